"""Along the load path: increments that end where a node touches or lets go, at a turning point or at a regular instant."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.energy import IncrementEnergy, increment_energy
from halfplane_fe.events import Event, Landing, LoadsAt, arrive, landed, next_event
from halfplane_fe.path import Stretch, enclosed
from scenes import ConvergenceError

# Share of a regular increment below which a failure is passed on, and a step error accepted (and counted), instead of halved.
_SHORTEST = 2.0**-12
_SHORTEST_FOR_ERROR = 2.0**-5
# Share of the leg within which an event is met.
_LANDING_TOLERANCE = 2e-11
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
    problem: ContactProblem, history: InterfaceState, stretch: Stretch, scale: float, allowed: Callable[[float], float]
) -> Iterator[Increment]:
    """Increments along one stretch of the path, loads divided by `scale`.

    Landing on each node's touch (from where its slip counts) and release (up to where its friction works) leaves no increment with
    a node that is closed for a part of it only (`events`). An increment that does not converge, or whose step error is above
    `allowed` (of its duration), is halved; the history it started from is a value, so that the rejected attempt leaves no trace.

    Raises
    ------
    ConvergenceError
        Where halving does not help, or events do not end.
    """

    def loads_at(time: float) -> tuple[float, float]:
        p, q = stretch.leg.loads(time)
        return float(p) / scale, float(q) / scale

    def area(end: float) -> float:
        return enclosed(stretch.leg, history.time, end) / scale**2

    regular = stretch.ends[0] - stretch.start

    def too_long(solved: InterfaceState) -> bool:
        duration = solved.time - history.time
        error = increment_energy(problem, history, solved, 0.0).step_error
        return error > allowed(duration) and duration > _SHORTEST_FOR_ERROR * regular

    landing = Landing(_LANDING_TOLERANCE * (stretch.leg.end - stretch.leg.start), too_long)
    for end in stretch.ends:
        targets = [end]  # the first is to be reached, those after it are what halving has put before it
        for _ in range(_MOST_TRIALS + _MOST_EVENTS * len(problem.height)):
            attempt = _attempt(problem, history, (loads_at, area), targets[-1], landing, regular)
            if isinstance(attempt, float):
                targets.append((history.time + attempt) / 2)
                continue
            if attempt.energy.step_error > allowed(attempt.solved.time - history.time):
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
    problem: ContactProblem,
    history: InterfaceState,
    loads: tuple[LoadsAt, Callable[[float], float]],
    end: float,
    landing: Landing,
    regular: float,
) -> Increment | float:
    """The increment to the first event or to `end`, or the instant to which it was tried where it shall be halved."""
    loads_at, area = loads
    predicted = next_event(problem, history, loads_at, end)
    try:
        solved, event, iterations = arrive(problem, history, loads_at, predicted, end, landing)
    except ConvergenceError:
        if predicted[1] - history.time < _SHORTEST * regular:
            raise
        problem.work["increments halved, not converged"] += 1
        return predicted[1]
    if landing.too_long(solved):
        problem.work["increments halved, step error"] += 1
        return solved.time
    share = (solved.time - history.time) / regular
    energy = increment_energy(problem, history, solved, area(solved.time))
    return Increment(solved, landed(solved, event), energy, iterations, event, share)
