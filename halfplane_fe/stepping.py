"""Along the load path: increments that end where a node touches or lets go, at a turning point or
at a regular instant.

With the states of the nodes held, forces are linear in the loads, and the normal problem of like
bodies depends on P alone, or on P and the tilt: one linear prediction finds the event. Between
unlike bodies it depends on Q too, and on what sticks. There the prediction misses by the square of
the increment. It is repeated with the sliding nodes that the increment has ended with: a node that
lets go before the end of its increment would be open there, and the friction work of the whole
increment would be lost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from halfplane_fe.arrays import Array, Mask, States
from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState, nodal
from halfplane_fe.energy import step_errors
from halfplane_fe.path import Stretch, scaled_loads
from halfplane_fe.systems import SingularSet
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, ConvergenceError, freeze

Event = Literal["regular", "touch", "release"]
LoadsAt = Callable[[float], tuple[float, ...]]

# Gap and nodal force within which a node counts as met by an event, scaled.
_LANDED = 1e-9
# The same within which it is met for good, and share of the increment by which its end may move for
# that.
_MET, _NEAR = 1e-14, 1e-3
# Share of a regular increment below which a failure is passed on, and a step error accepted (and
# counted), instead of halved.
_SHORTEST = 2.0**-12
_SHORTEST_FOR_ERROR = 2.0**-5
# Share of an increment's step error that its half has at least where the interface jumps (elsewhere
# a quarter); jumps of a run that has an answer: nine at most in those of the first 200 random loops
# that are between unlike bodies, but for loop 89.
_JUMP, _MOST_JUMPS = 0.9, 12
_JUMPY = (
    "contact: the interface jumped from one solution to another in {count} increments, the last at"
    " time {time:.6g}, however short they are; mesh the softer body as finely as the other one"
    " (upper_ratio)"
)
# Predictions of an event of unlike bodies, each with the sliding nodes that the one before has led
# to: the second one meets it, but where it meets another node first.
_MOST_PREDICTIONS = 5
# Secants before an event is bracketed instead.
_MOST_SECANTS = 8
# Trials of a regular increment: all of its halves down to the shortest and as many refused; and of
# each contact node, eight events.
_MOST_TRIALS, _MOST_EVENTS = 2**14, 8


@dataclass(frozen=True, eq=False)
class Increment:
    """One accepted increment: the state that it leaves behind as history, and how it was found.

    Attributes
    ----------
    state : at its end
    solved : (n,) states of the nodes that were solved for. They differ from those of `state` at
        events only: there a node that touches or lets go has changed sides at the very end
    step_error : see `energy.step_errors`
    iterations : of the active set
    event : what the increment ends with
    """

    state: InterfaceState
    solved: States
    step_error: float
    iterations: int
    event: Event


def follow(
    problem: ContactProblem,
    history: InterfaceState,
    stretch: Stretch,
    units: tuple[float, ...],
    allowed: Callable[[float], float],
) -> Iterator[Increment]:
    """Increments along one stretch of the path, each load divided by its unit.

    Landing on each node's touch (from where its slip counts) and release (up to where its friction
    works) leaves no increment with a node that is closed for a part of it only. An increment that
    does not converge, or whose step error is above `allowed` (of its duration), is halved; the
    history it started from is a value, so that the rejected attempt leaves no trace. Where half an
    increment has the error of the whole, the interface jumps from one solution to another: halving
    ends there.

    Raises
    ------
    ConvergenceError
        Where halving does not help, or events do not end.
    """

    @cache
    def loads_at(time: float) -> tuple[float, ...]:
        return scaled_loads(stretch.leg, time, units)

    regular = stretch.ends[0] - stretch.start
    for end in stretch.ends:
        # the first is to be reached, those after it are what halving has put before it
        targets = [end]
        refused, jumps = (history.time, np.inf), False
        for _ in range(_MOST_TRIALS + _MOST_EVENTS * len(problem.height)):
            attempt = _attempt(problem, history, loads_at, targets[-1], _SHORTEST * regular)
            if isinstance(attempt, float):
                targets.append((history.time + attempt) / 2)
                continue
            duration, error = attempt.state.time - history.time, attempt.step_error
            if error > allowed(duration):
                if refused[0] == history.time and error > _JUMP * refused[1]:
                    jumps = True
                    problem.jumps += 1
                    problem.work["increments that jump"] += 1
                    if problem.jumps > _MOST_JUMPS:
                        raise ConvergenceError(
                            _JUMPY.format(count=problem.jumps, time=history.time)
                        )
                if duration > _SHORTEST_FOR_ERROR * regular and not jumps:
                    refused = history.time, error
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
            raise ConvergenceError(
                f"the increment that ends at time {end:.6g} was not reached: nodes touch and let go"
                " without end"
            )


def _attempt(
    problem: ContactProblem, history: InterfaceState, loads_at: LoadsAt, end: float, shortest: float
) -> Increment | float:
    """The increment to the first event or to `end`; the instant to which it was tried where that
    does not converge, unless it is `shortest`."""
    event, time = next_event(problem, history, loads_at, end, history.state)
    try:
        solved, iterations = problem.equilibrium(history, time, loads_at(time))
        for _ in range(_MOST_PREDICTIONS - 1):
            if not _misses(problem, history, solved, event):
                break
            sliding = _on_its_side(history, solved, solved.closed != history.closed)
            event, time = next_event(problem, history, loads_at, end, sliding)
            if time == solved.time:
                break
            solved, more = problem.equilibrium(history, time, loads_at(time))
            iterations += more
            problem.work["events predicted again"] += 1
        if (
            event != "regular"
            and (met := _met(problem, history, loads_at, solved, event, end)) != time
        ):
            solved, more = problem.equilibrium(history, met, loads_at(met))
            iterations += more
    except ConvergenceError:
        if time - history.time < shortest:
            raise
        problem.work["increments halved, not converged"] += 1
        return time
    states = up_to_event(history, solved)
    error = 0.0
    if not np.array_equal(states, history.state):
        slip, pressure, _, _ = nodal(solved.values - history.values)
        error = float(step_errors(problem.friction, pressure, slip, history.state, states))
    return Increment(landed(replace(solved, state=states), event), states, error, iterations, event)


def next_event(
    problem: ContactProblem,
    history: InterfaceState,
    loads_at: LoadsAt,
    end: float,
    states: States,
) -> tuple[Event, float]:
    """What happens first up to `end` to the set of touching nodes, and when, by one linear
    prediction.

    Parameters
    ----------
    states : (n,) that the nodes have on the way. Those that touch are the ones of `history`
    """
    start = history
    try:
        # nodes that start to slide come to the limit of friction at once
        if states is not history.state:
            start = problem.following(history, history.time, history.loads, states)
        held = problem.following(history, end, loads_at(end), states)
    except SingularSet:
        # one node is left: the upper body rolls over it, to where another touches, and nothing
        # foresees it
        return "regular", end
    closed = history.closed
    _, pressure, _, gap = nodal(start.values)
    _, pressed, _, left_open = nodal(held.values)
    touch, release = (
        _first_crossing(gap, left_open, ~closed),
        _first_crossing(pressure, pressed, closed),
    )
    event: Event = "touch" if touch <= release else "release"
    share, node = min(touch, release)
    if share >= 1.0:
        return "regular", end
    if len(history.loads) == 2 and problem.interface.coupling is None:
        wanted = history.loads[0] + share * (held.loads[0] - history.loads[0])
        if not min(history.loads[0], held.loads[0]) < wanted < max(history.loads[0], held.loads[0]):
            return "regular", end
        before = history.loads[0] - wanted

        def left(time: float) -> float:
            return loads_at(time)[0] - wanted

    else:
        # by Q and by tilt nodes meet at constant P too: the gap or the force of the first of them,
        # as the loads go
        moving = np.flatnonzero(np.subtract(held.loads, history.loads)).tolist()
        part = 3 if event == "touch" else 1
        by_load = nodal(problem.rates(states, len(history.loads))[moving])[part, :, node]
        before = float(nodal(start.values)[part, node])

        def left(time: float) -> float:
            return before + float(np.subtract(loads_at(time), history.loads)[moving] @ by_load)

    time = _zero(left, history.time, end, share, before)
    return (event, time) if history.time < time < end else ("regular", end)


def _misses(
    problem: ContactProblem, history: InterfaceState, solved: InterfaceState, event: Event
) -> bool:
    """Whether a node of unlike bodies meets its event before the increment ends, or the increment
    ends before its event.
    """
    if problem.interface.coupling is None:
        return False
    at_event = _marginal(solved)
    too_far = np.any((solved.closed != history.closed) & ~at_event)
    too_short = event != "regular" and not np.any(
        at_event & (history.closed == (event == "release"))
    )
    return bool(too_far or too_short)


def _met(
    problem: ContactProblem,
    history: InterfaceState,
    loads_at: LoadsAt,
    solved: InterfaceState,
    event: Event,
    end: float,
) -> float:
    """When the event that `solved` meets to `_LANDED` is met to rounding: nodes that start or end
    to slide bend the way to it.
    """
    meets = _marginal(solved) & (history.closed == (event == "release"))
    left = np.where(meets, np.where(solved.closed, solved.pressure, solved.gap), 0.0)
    node, start, time = int(np.argmax(np.abs(left))), history.time, solved.time
    if abs(left[node]) <= _MET:
        return time
    by_load = nodal(problem.rates(solved.state, len(solved.loads)))[
        1 if solved.closed[node] else 3, :, node
    ]

    def missed(at: float) -> float:
        return float(left[node] + np.subtract(loads_at(at), solved.loads) @ by_load)

    met = _zero(missed, start, end, (time - start) / (end - start), missed(start))
    return met if abs(met - time) < _NEAR * (time - start) else time


def _zero(
    function: Callable[[float], float], low: float, high: float, share: float, at_low: float
) -> float:
    """Where a function that is next to linear is zero, near that share of the way; by secants, and
    bracketed where they miss.
    """
    before, time = low, low + share * (high - low)
    value_before, value = at_low, function(time)
    for _ in range(_MOST_SECANTS):
        if value in (0.0, value_before):
            return time
        step = -value * (time - before) / (value - value_before)
        if abs(step) <= 4e-16 * abs(time):
            return time
        before, value_before, time = time, value, time + step
        if not low <= time <= high:
            break
        value = function(time)
    if not at_low * function(high) < 0:
        return high
    return float(brentq(function, low, high, xtol=1e-15, rtol=8.9e-16))


def _first_crossing(before: Array, after: Array, nodes: Mask) -> tuple[float, int]:
    """Fraction of the increment at which the first of `nodes` goes from positive to negative,
    linearly, and it; 1 if none does.
    """
    falling = np.flatnonzero(nodes & (before > ROUNDING) & (after < -ROUNDING))
    if not len(falling):
        return 1.0, -1
    shares = before[falling] / (before[falling] - after[falling])
    first = int(np.argmin(shares))
    return float(shares[first]), int(falling[first])


def up_to_event(history: InterfaceState, solved: InterfaceState) -> States:
    """(n,) solved states, nodes that are at their event on the side where they have been: within
    rounding the law takes either.

    A node that let go in its increment has slid for all of it, and one labelled open would lose the
    friction work.
    """
    changed = _marginal(solved) & (solved.closed != history.closed)
    return _on_its_side(history, solved, changed) if changed.any() else solved.state


def _on_its_side(history: InterfaceState, solved: InterfaceState, changed: Mask) -> States:
    """(n,) solved states; those that `changed` sides on the one where they have been: open, stuck
    or sliding as they have moved.
    """
    slip = solved.slip - history.slip
    sliding = np.where(slip > ROUNDING, SLIP_FORWARD, SLIP_REVERSE)
    closed_until_now = np.where(np.abs(slip) > ROUNDING, sliding, STICK)
    return freeze(
        np.where(changed, np.where(history.closed, closed_until_now, OPEN), solved.state), np.int8
    )


def _marginal(state: InterfaceState) -> Mask:
    return (np.abs(state.gap) <= _LANDED) & (np.abs(state.pressure) <= _LANDED)


def landed(state: InterfaceState, event: Event) -> InterfaceState:
    """`state` with the nodes of the event on their new side: a touching node sticks from here on, a
    released one is open.
    """
    if event == "regular":
        return state
    new = STICK if event == "touch" else OPEN
    return replace(state, state=freeze(np.where(_marginal(state), new, state.state), np.int8))
