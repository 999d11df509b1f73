"""Along the load path: increments that end where a node touches or lets go, at a turning point or at a regular instant."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.energy import IncrementEnergy, increment_energy
from halfplane_fe.events import Event, landed, next_event, up_to_event
from halfplane_fe.path import Stretch, enclosed, scaled_loads
from scenes import ConvergenceError

# Share of a regular increment below which a failure is passed on, and a step error accepted (and counted), instead of halved.
_SHORTEST = 2.0**-12
_SHORTEST_FOR_ERROR = 2.0**-5
# Trials of a regular increment: all of its halves down to the shortest and as many refused; and of each contact node, eight events.
_MOST_TRIALS, _MOST_EVENTS = 2**14, 8


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
    event: Event
    share: float


def follow(
    problem: ContactProblem, history: InterfaceState, stretch: Stretch, units: tuple[float, ...], allowed: Callable[[float], float]
) -> Iterator[Increment]:
    """Increments along one stretch of the path, each load divided by its unit.

    Landing on each node's touch (from where its slip counts) and release (up to where its friction works) leaves no increment with
    a node that is closed for a part of it only (`events`). An increment that does not converge, or whose step error is above
    `allowed` (of its duration), is halved; the history it started from is a value, so that the rejected attempt leaves no trace.

    Raises
    ------
    ConvergenceError
        Where halving does not help, or events do not end.
    """

    regular = stretch.ends[0] - stretch.start
    for end in stretch.ends:
        targets = [end]  # the first is to be reached, those after it are what halving has put before it
        for _ in range(_MOST_TRIALS + _MOST_EVENTS * len(problem.height)):
            attempt = _attempt(problem, history, stretch, units, targets[-1])
            if isinstance(attempt, float):
                targets.append((history.time + attempt) / 2)
                continue
            duration = attempt.solved.time - history.time
            if attempt.energy.step_error > allowed(duration):
                if duration > _SHORTEST_FOR_ERROR * regular:
                    problem.work["increments halved, step error"] += 1
                    targets.append(history.time + duration / 2)
                    continue
                problem.work["increments above the step tolerance"] += 1
            history = attempt.state
            problem.work[f"{attempt.event} increments"] += 1
            yield attempt
            while targets and history.time >= targets[-1]:
                targets.pop()
            if not targets:
                break
        else:
            raise ConvergenceError(f"the increment that ends at time {end:.6g} was not reached: nodes touch and let go without end")


def _attempt(
    problem: ContactProblem, history: InterfaceState, stretch: Stretch, units: tuple[float, ...], end: float
) -> Increment | float:
    """The increment to the first event or to `end`; the instant to which it was tried where that does not converge."""

    def loads_at(time: float) -> tuple[float, ...]:
        return scaled_loads(stretch.leg, time, units)

    regular = stretch.ends[0] - stretch.start
    event, time = next_event(problem, history, loads_at, end)
    try:
        solved, iterations = problem.equilibrium(history, time, loads_at(time))
    except ConvergenceError:
        if time - history.time < _SHORTEST * regular:
            raise
        problem.work["increments halved, not converged"] += 1
        return time
    solved = up_to_event(history, solved)
    area = enclosed(stretch.leg, history.time, time)
    if area is not None:
        area /= np.multiply.outer(units[: len(area)], units[: len(area)])
    energy = increment_energy(problem, history, solved, area)
    return Increment(solved, landed(solved, event), energy, iterations, event, (time - history.time) / regular)
