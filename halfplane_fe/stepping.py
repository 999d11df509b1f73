"""Along the load path: increments that end where a node touches or lets go, at a turning point or at a regular instant."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState
from halfplane_fe.energy import IncrementEnergy, increment_energy
from halfplane_fe.path import Stretch
from scenes import ConvergenceError, SurfaceState, freeze

Array = NDArray[np.float64]
# Gap and nodal force within which a node counts as met by an event, scaled.
_LANDED = 1e-9

# Share of a regular increment below which a failure is passed on, and a step error accepted (and counted), instead of halved.
_SHORTEST = 2.0**-12
_SHORTEST_FOR_ERROR = 2.0**-5

LoadsAt = Callable[[float], tuple[float, float]]


@dataclass(frozen=True, eq=False)
class Increment:
    """One accepted increment: the state that was solved, the state it leaves behind as history, and how it was found.

    The two states differ at events only: there a node that touches or lets go has changed sides at the very end.

    Attributes
    ----------
    event : what the increment ends with, "regular", "touch" or "release"
    share : its duration over that of a regular increment
    """

    solved: InterfaceState
    state: InterfaceState
    energy: IncrementEnergy
    iterations: int
    event: str
    share: float


def follow(
    problem: ContactProblem, history: InterfaceState, stretch: Stretch, scale: float, allowed: Callable[[float], float]
) -> Iterator[Increment]:
    """Increments along one stretch of the path, loads divided by `scale`.

    Between two events the discrete normal problem is linear in P, so landing on each node's touch (from where its slip counts) and
    release (up to where its friction works) leaves no increment with a node that is closed for a part of it only. An increment
    that does not converge, or whose step error is above `allowed` (of its duration), is halved; the history it started from is a
    value, so that the rejected attempt leaves no trace.

    Raises
    ------
    ConvergenceError
        Where halving does not help.
    """

    def loads_at(time: float) -> tuple[float, float]:
        p, q = stretch.leg.loads(time)
        return float(p) / scale, float(q) / scale

    regular = stretch.ends[0] - stretch.start
    for end in stretch.ends:
        targets = [end]  # the first is to be reached, those after it are what halving has put before it
        while targets:
            event, time = _next_event(problem, history, loads_at, targets[-1])
            share = (time - history.time) / regular
            increment = _attempt(problem, history, time, loads_at(time), allowed, event, share)
            if increment is None:
                targets.append((history.time + time) / 2)
                continue
            history = increment.state
            problem.work[f"{event} increments"] += 1
            yield increment
            while targets and history.time >= targets[-1]:
                targets.pop()


def _attempt(
    problem: ContactProblem,
    history: InterfaceState,
    time: float,
    loads: tuple[float, float],
    allowed: Callable[[float], float],
    event: str,
    share: float,
) -> Increment | None:
    """The increment to `time`, a `share` of a regular one, or None where it shall be halved."""
    try:
        solved, iterations = problem.equilibrium(history, time, loads)
    except ConvergenceError:
        if share < _SHORTEST:
            raise
        problem.work["increments halved, not converged"] += 1
        return None
    energy = increment_energy(problem, history, solved)
    if energy.step_error > allowed(time - history.time):
        if share > _SHORTEST_FOR_ERROR:
            problem.work["increments halved, step error"] += 1
            return None
        problem.work["increments above the step tolerance"] += 1
    return Increment(solved, _landed(solved, event), energy, iterations, event, share)


def _next_event(problem: ContactProblem, history: InterfaceState, loads_at: LoadsAt, end: float) -> tuple[str, float]:
    """What happens first up to `end` to the set of touching nodes, and when."""
    held = problem.holding(history, end, loads_at(end))
    fractions = {
        "touch": _first_crossing(history.gap, held.gap, ~history.closed),
        "release": _first_crossing(history.pressure, held.pressure, history.closed),
    }
    event = min(fractions, key=lambda name: fractions[name])
    if fractions[event] >= 1.0:
        return "regular", end
    start_load, end_load = loads_at(history.time)[0], loads_at(end)[0]
    wanted = start_load + fractions[event] * (end_load - start_load)
    if not min(start_load, end_load) < wanted < max(start_load, end_load):
        return "regular", end
    time = float(brentq(lambda t: loads_at(t)[0] - wanted, history.time, end, xtol=1e-15, rtol=8.9e-16))
    if not history.time < time < end:
        return "regular", end
    return event, time


def _first_crossing(before: Array, after: Array, nodes: NDArray[np.bool_]) -> float:
    """Fraction of the increment at which the first of `nodes` goes from positive to negative, linearly; 1 if none does."""
    falling = nodes & (before > ROUNDING) & (after < -ROUNDING)
    if not falling.any():
        return 1.0
    return float(np.min(before[falling] / (before[falling] - after[falling])))


def _landed(state: InterfaceState, event: str) -> InterfaceState:
    """`state` with the nodes of the event on their new side: a touching node sticks from here on, a released one is open."""
    if event == "regular":
        return state
    marginal = (np.abs(state.gap) <= _LANDED) & (np.abs(state.pressure) <= _LANDED)
    new = SurfaceState.STICK if event == "touch" else SurfaceState.OPEN
    return replace(state, state=freeze(np.where(marginal, new, state.state), np.int8))
