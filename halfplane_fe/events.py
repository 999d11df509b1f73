"""Events: when the next node touches or lets go, and arriving there.

With the states of the nodes held, forces are linear in the loads, and the normal problem of like bodies depends on P alone: one
linear prediction finds the event. Between unlike bodies it depends on Q too, and on what sticks; there the prediction only starts a
secant on the room r of each node, its gap while it is open, its nodal force while it is closed, less the other of the two:

    r(t) > 0 before the node's event, < 0 behind it, with a kink and no jump there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, freeze

Array = NDArray[np.float64]
Event = Literal["regular", "touch", "release"]
LoadsAt = Callable[[float], tuple[float, float]]

# Solves after which an event that is not met is counted instead.
_MOST_SOLVES = 25
# Gap and nodal force within which a node counts as met by an event, scaled.
_LANDED = 1e-9


class Arrival(NamedTuple):
    """The state at the end of an increment, what it ends with, and the iterations it took."""

    solved: InterfaceState
    event: Event
    iterations: int


class Landing(NamedTuple):
    """Time within which an event is to be met, and whether an increment is to be halved, so that landing would be wasted on it."""

    within: float
    too_long: Callable[[InterfaceState], bool]


@dataclass(frozen=True, eq=False)
class _Point:
    """An instant and the room (n,) that each node has there; without end for nodes that were at their event from the start."""

    time: float
    room: Array

    @property
    def behind(self) -> bool:
        """Whether some node's event has passed."""
        return bool(self.room.min() < 0)


def next_event(problem: ContactProblem, history: InterfaceState, loads_at: LoadsAt, end: float) -> tuple[Event, float]:
    """What happens first up to `end` to the set of touching nodes, and when, by one linear prediction."""
    held = problem.holding(history, end, loads_at(end))
    fractions: dict[Event, float] = {
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


def arrive(
    problem: ContactProblem,
    history: InterfaceState,
    loads_at: LoadsAt,
    predicted: tuple[Event, float],
    end: float,
    landing: Landing,
) -> Arrival:
    """Solve up to the first event, or up to `end` where there is none, starting from the prediction.

    Like bodies take the prediction as it is. The solves that unlike ones need beyond the first are counted in `work`, and so is an
    event that was not met in time.

    Raises
    ------
    ConvergenceError
        Of any of the solves.
    """
    event, time = predicted
    solved, iterations = problem.equilibrium(history, time, loads_at(time))
    if problem.interface.coupling is None or not problem.tangential or landing.too_long(solved):
        return Arrival(_up_to_event(history, solved), event, iterations)
    points = [_point(history, history)]
    for _ in range(_MOST_SOLVES):
        points.append(_point(history, solved))
        if time == end and not points[-1].behind:
            return Arrival(solved, "regular", iterations)
        # An event is met from before it: a node that has let go at the end of its increment would lose the friction work of it.
        better = _next_instant(points, end)
        if not points[-1].behind and better - time <= landing.within:
            return Arrival(_up_to_event(history, solved), _kind(history, points[-1]), iterations)
        time = max(better - landing.within / 2, (history.time + better) / 2) if better < end else end
        # Within rounding a node keeps the side that it starts on: here the one that it is on up to its event.
        start = np.where(solved.closed == history.closed, solved.state, history.state)
        solved, more = problem.equilibrium(history, time, loads_at(time), start)
        iterations += more
        problem.work["landing solves"] += 1
    problem.work["events not landed on"] += 1
    return Arrival(solved, _kind(history, _point(history, solved)), iterations)


def _room(history: InterfaceState, state: InterfaceState) -> Array:
    open_by = state.gap - state.pressure
    return np.where(history.closed, -open_by, open_by)


def _point(history: InterfaceState, state: InterfaceState) -> _Point:
    at_event = _room(history, history) <= ROUNDING
    return _Point(state.time, np.where(at_event, np.inf, _room(history, state)))


def _kind(history: InterfaceState, point: _Point) -> Event:
    return "release" if history.closed[point.room.argmin()] else "touch"


def _next_instant(points: list[_Point], end: float) -> float:
    """Secant through the last point and the one before it on its own side of the event, kept between the two sides."""
    last = points[-1]
    before = max(point.time for point in points if not point.behind)
    behind = min((point.time for point in points if point.behind), default=np.inf)
    own = [point for point in points[:-1] if point.behind == last.behind] or points[:-1]
    found = _first_zero(own[-1], last)
    if found >= end and np.isinf(behind):
        return end
    return found if before <= found <= behind else (before + min(behind, end)) / 2


def _first_zero(first: _Point, second: _Point) -> float:
    """Instant at which the first of the rooms, linear through two points, falls through zero; infinite if none does."""
    watched = np.isfinite(first.room)
    if second.time == first.time:  # two instants that are one to rounding tell no slope
        return np.inf
    slope = (second.room[watched] - first.room[watched]) / (second.time - first.time)
    falling = slope < 0
    return float(np.min(second.time - second.room[watched][falling] / slope[falling], initial=np.inf))


def _up_to_event(history: InterfaceState, solved: InterfaceState) -> InterfaceState:
    """`solved` with nodes that are at their event on the side where they have been: there, within rounding, the law takes either.

    A node that let go in its increment has slid for all of it, and one labelled open would lose the friction work.
    """
    slip = solved.slip - history.slip
    sliding = np.where(slip > ROUNDING, SLIP_FORWARD, SLIP_REVERSE)
    closed_until_now = np.where(np.abs(slip) > ROUNDING, sliding, STICK)
    changed = _marginal(solved) & (solved.closed != history.closed)
    states = np.where(changed, np.where(history.closed, closed_until_now, OPEN), solved.state)
    return replace(solved, state=freeze(states, np.int8))


def _marginal(state: InterfaceState) -> NDArray[np.bool_]:
    return (np.abs(state.gap) <= _LANDED) & (np.abs(state.pressure) <= _LANDED)


def landed(state: InterfaceState, event: Event) -> InterfaceState:
    """`state` with the nodes of the event on their new side: a touching node sticks from here on, a released one is open."""
    if event == "regular":
        return state
    new = STICK if event == "touch" else OPEN
    return replace(state, state=freeze(np.where(_marginal(state), new, state.state), np.int8))
