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
from typing import Literal, NamedTuple

import numpy as np
import scipy

from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState, nodal
from halfplane_fe.energy import step_errors, work_by_kinks
from halfplane_fe.law import slip_sign
from halfplane_fe.path import Stretch, scaled_loads, straight, zero_between
from halfplane_fe.systems import SingularSet
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, ConvergenceError, freeze
from scenes.array_types import Array, Mask, States

Event = Literal["regular", "touch", "release"]
"""What ends an increment: an open node touches, a closed one is released (lets go), or neither, at
a regular instant.
"""

LoadsAt = Callable[[float], tuple[float, ...]]

# Gap and nodal force within which a node counts as met by an event, scaled.
_LANDED = 1e-9
# The same within which it is met for good,
_MET = 1e-14
# and share of the increment by which its end may move for that.
_LARGEST_MOVE = 1e-3
# Share of a regular increment below which a failure is passed on, and a step error accepted (and
# counted), instead of halved.
_SHORTEST = 2.0**-12
_SHORTEST_FOR_ERROR = 2.0**-5
# Share of an increment's step error that its half has at least where the interface jumps (elsewhere
# a quarter).
_JUMP = 0.9
# Jumps of a run that has an answer: nine at most in those of the first 200 random loops that are
# between unlike bodies, but for loop 89.
_MOST_JUMPS = 12
_JUMPY = (
    "contact: the interface jumped from one solution to another in {count} increments, the last at"
    " time {time:.6g}, however short they are; mesh the softer body as finely as the other one"
    " (upper_ratio)"
)
# Predictions of an event of unlike bodies, each with the sliding nodes that the one before has led
# to: the second one meets it, but where it meets another node first.
_MOST_PREDICTIONS = 5
# Instants of an increment at which the end of a stroke is looked for, and the share of it to which
# that is found: slip rests there, so that its square counts.
_LOOKED_AT = 9
_TURN = 1e-5
# Trials of a regular increment: all of its halves down to the shortest and as many refused.
_MOST_TRIALS = 2**14
# Events of a contact node in a regular increment.
_MOST_EVENTS = 8


@dataclass(frozen=True)
class StepTolerance:
    """Errors of the dissipation with which an increment is accepted.

    Attributes
    ----------
    rate
        the largest error of an increment over its duration, scaled
    of_kinks
        whether the error of an increment is no more than what kinks between the first and the
        last start of sliding add (`energy.work_by_kinks`): so it is of like bodies, whose pressure
        does not depend on what slides. Else it is the bound of `energy.step_errors`
    """

    rate: float
    of_kinks: bool = False


@dataclass(frozen=True, eq=False)
class Increment:
    """One increment: the state that it leaves behind, and how it was found.

    Attributes
    ----------
    state
        at its end
    solved
        (n,) states of the nodes that were solved for. They differ from those of `state` at
        events only: there a node that touches or lets go has changed sides at the very end
    step_error
        see `energy.step_errors`
    iterations
        of the active set
    event
        what the increment ends with
    """

    state: InterfaceState
    solved: States
    step_error: float
    iterations: int
    event: Event


class NotConverged(NamedTuple):
    """An increment that does not converge, tried to this instant."""

    time: float


def follow(
    problem: ContactProblem,
    state: InterfaceState,
    stretch: Stretch,
    units: tuple[float, ...],
    tolerance: StepTolerance,
) -> Iterator[Increment]:
    """Increments from a state along one stretch of the path, a leg of it with the times at which
    increments are to end; each load is divided by its unit.

    An increment ends where a node touches or lets go, so that no node is closed for a part of an
    increment only. It ends where a load turns too, and on curved legs where slip ends on its way.
    An increment that does not converge, or whose step error is above the tolerance, is halved. The
    state that it started from is a value, so that the rejected attempt leaves no trace.

    The shortest increments are accepted with a larger step error, and counted. Between unlike
    bodies halving may not lessen the error: the interface jumps from one solution to another, and
    the increment is accepted.

    Raises
    ------
    ConvergenceError
        Where halving does not help, the interface jumps too often, or events do not end.
    """

    @cache
    def loads_at(time: float) -> tuple[float, ...]:
        return scaled_loads(stretch.leg, time, units)

    # Along a straight leg slip that falls at its end falls from its start on: none is lost.
    is_curved = not straight(stretch.leg)
    regular = stretch.ends[0] - stretch.start
    for end in stretch.ends:
        control = _ErrorControl(problem, tolerance, _SHORTEST_FOR_ERROR * regular)
        # the first is to be reached, those after it are what halving has put before it
        targets = [end]
        for _ in range(_MOST_TRIALS + _MOST_EVENTS * len(problem.height)):
            target = _up_to_turn(problem, state, loads_at, targets[-1])
            attempt = _attempt(problem, state, loads_at, target, _SHORTEST * regular)
            if isinstance(attempt, NotConverged):
                targets.append((state.time + attempt.time) / 2)
                continue
            end_of_slip = attempt.state.time
            if is_curved:
                end_of_slip = _end_of_lost_slip(problem, state, attempt, loads_at, tolerance)
            if control.is_longer(end_of_slip - state.time) and end_of_slip < attempt.state.time:
                problem.work["increments ended where slip ends"] += 1
                targets.append(end_of_slip)
                continue
            if not control.accepts(attempt, state):
                targets.append(state.time + (attempt.state.time - state.time) / 2)
                continue
            state = attempt.state
            problem.work[f"{attempt.event} increments"] += 1
            yield attempt
            while targets and state.time >= targets[-1]:
                targets.pop()
            if not targets:
                break
        else:
            raise ConvergenceError(
                f"the increment that ends at time {end:.6g} was not reached: nodes touch and let go"
                " without end"
            )


def _up_to_turn(
    problem: ContactProblem, start: InterfaceState, loads_at: LoadsAt, end: float
) -> float:
    """The instant up to `end` at which a stroke of slip that begins at `start` ends, or `end`.

    Of given loads it is known beforehand (`path.turning_points`). Where movements are given it
    follows from what slides: there the slip of the sliding nodes, each weighted by its friction,
    grows no further as the movements go.
    """
    if not problem.actuators.are_there:
        return end
    slip_directions = slip_sign(start.state)
    if not slip_directions.any():
        return end
    try:
        slip_by_loads, _, _, _ = nodal(problem.rates(start.state, len(start.loads)))
    except SingularSet:
        return end
    progress_by_loads = slip_by_loads @ (slip_directions * start.pressure)
    end_of_stroke = _end_of_stroke(start, loads_at, end, progress_by_loads)
    first_look = start.time + (end - start.time) / (_LOOKED_AT - 1)
    return end_of_stroke if end_of_stroke > first_look else end


def _end_of_stroke(
    start: InterfaceState, loads_at: LoadsAt, end: float, progress_by_loads: Array
) -> float:
    """The instant up to `end` at which the progress of slip since `start` is largest.

    Parameters
    ----------
    progress_by_loads
        (n_loads,) its rates
    """

    def progress(time: float) -> float:
        return float(np.subtract(loads_at(time), start.loads) @ progress_by_loads)

    times = np.linspace(start.time, end, _LOOKED_AT)
    number_of_largest = int(np.argmax([progress(time) for time in times.tolist()]))
    if number_of_largest == _LOOKED_AT - 1:
        return end
    minimum = scipy.optimize.minimize_scalar(
        lambda time: -progress(time),
        bounds=(times[max(number_of_largest - 1, 0)], times[number_of_largest + 1]),
        method="bounded",
        options={"xatol": _TURN * (end - start.time)},
    )
    return float(minimum.x)


def _end_of_lost_slip(
    problem: ContactProblem,
    start: InterfaceState,
    increment: Increment,
    loads_at: LoadsAt,
    tolerance: StepTolerance,
) -> float:
    """The instant at which slip ends that an increment loses, by more friction work than the
    tolerance; the end of the increment where it loses less.

    Between like half-planes all slip ends where Q - f P or Q + f P turns round, and there
    increments end. Other bodies stop a little earlier or later, one node after the other. A node
    that slides on its way and sticks later has slid less at the end of the increment than it had
    when it stopped, or not at all.
    """
    end = increment.state.time
    directions = slip_sign(start.state)
    if not directions.any():
        return end
    try:
        slip_by_loads, _, _, _ = nodal(problem.rates(start.state, len(start.loads)))
    except SingularSet:
        return end
    last_look = end - (end - start.time) / (_LOOKED_AT - 1)
    last_rise = np.subtract(loads_at(end), loads_at(last_look)) @ slip_by_loads
    has_turned = directions * last_rise < 0
    if not has_turned.any():
        return end
    times = np.linspace(start.time, end, _LOOKED_AT)
    changes_of_loads = np.subtract([loads_at(time) for time in times.tolist()], start.loads)
    slip = directions * (changes_of_loads @ slip_by_loads)
    slip_left = np.maximum(directions * (increment.state.slip - start.slip), 0.0)
    lost_slip = np.where(has_turned, np.maximum(slip.max(axis=0) - slip_left, 0.0), 0.0)
    lost_work = problem.friction * start.pressure * lost_slip
    if not lost_work.sum() > tolerance.rate * (end - start.time):
        return end
    weights = np.where(lost_work > 0, directions * start.pressure, 0.0)
    return _end_of_stroke(start, loads_at, end, slip_by_loads @ weights)


@dataclass
class _ErrorControl:
    """Whether the errors of the increments up to one regular instant are accepted.

    Attributes
    ----------
    shortest
        increments up to that duration are not halved
    refused_start, refused_error
        of the increment that was refused last
    jumps
        whether the interface has jumped, so that halving does not help
    """

    problem: ContactProblem
    tolerance: StepTolerance
    shortest: float
    refused_start: float = np.nan
    refused_error: float = np.inf
    jumps: bool = False

    def is_longer(self, duration: float) -> bool:
        """Whether an increment may be cut to that."""
        return duration > self.shortest

    def accepts(self, increment: Increment, start: InterfaceState) -> bool:
        """Whether the increment of a path, from the state `start`, is accepted; if not, it is to be
        halved.

        Its error is that of the work, over the time that it takes. Rejected ones are remembered: a
        half whose error is still that of the whole is a jump.

        Raises
        ------
        ConvergenceError
            Where the interface jumps too often.
        """
        duration = increment.state.time - start.time
        allowed_error = self.tolerance.rate * duration
        work_error = increment.step_error
        if not work_error > allowed_error:
            return True
        if self.tolerance.of_kinks:
            work_error = min(
                work_error, work_by_kinks(self.problem, start, increment.state, increment.solved)
            )
            if not work_error > allowed_error:
                return True
        # Like bodies have one solution. All their kinks can be in one half.
        elif self.refused_start == start.time and work_error > _JUMP * self.refused_error:
            self._count_jump(start.time)
        work = self.problem.work
        if duration > self.shortest and not self.jumps:
            self.refused_start = start.time
            self.refused_error = work_error
            work["increments halved, step error"] += 1
            return False
        work["increments above the step tolerance"] += 1
        return True

    def _count_jump(self, time: float) -> None:
        self.jumps = True
        self.problem.jumps += 1
        self.problem.work["increments that jump"] += 1
        if self.problem.jumps > _MOST_JUMPS:
            raise ConvergenceError(_JUMPY.format(count=self.problem.jumps, time=time))


def _attempt(
    problem: ContactProblem, start: InterfaceState, loads_at: LoadsAt, end: float, shortest: float
) -> Increment | NotConverged:
    """An increment from the state `start` to the first event on the way to the instant `end`, or
    `NotConverged`, to be tried with less; `loads_at` gives the loads at an instant.

    Raises
    ------
    ConvergenceError
        If an increment that is less than `shortest` does not converge.
    """
    trial = _Trial(problem, start, loads_at, end)
    try:
        event, solved = trial.solved()
    except ConvergenceError:
        if trial.target - start.time < shortest:
            raise
        problem.work["increments halved, not converged"] += 1
        return NotConverged(trial.target)
    states = up_to_event(start, solved)
    step_error = 0.0
    if not np.array_equal(states, start.state):
        slip, pressure, _, _ = nodal(solved.values - start.values)
        step_error = float(step_errors(problem.friction, pressure, slip, start.state, states))
    state = landed(replace(solved, state=states), event)
    return Increment(state, states, step_error, trial.iterations, event)


@dataclass
class _Trial:
    """The way to the end of one increment.

    Attributes
    ----------
    start_state
        state of the interface at the begin of the increment
    loads_at
        the scaled loads at an instant
    latest_end
        instant at which the increment ends at the latest
    target
        instant that was predicted last
    iterations
        of the active set, so far
    """

    problem: ContactProblem
    start_state: InterfaceState
    loads_at: LoadsAt
    latest_end: float
    target: float = np.nan
    iterations: int = 0

    def solved(self) -> tuple[Event, InterfaceState]:
        """The event that the increment ends with, and the state of the interface at that instant.

        The event is "touch" where an open node touches, "release" where a closed one lets go. It is
        "regular" where neither happens up to the latest end, at which the increment then ends.

        Event and instant are predicted with the states (open, stick, slip) that the nodes are
        expected to have on the way. Where a prediction misses the event, it is repeated with the
        states that came out, a few times at most. The instant of "touch" or "release" is then found
        to rounding, and the state is solved for there.

        Raises
        ------
        ConvergenceError
            If the active set does not converge.
        """
        expected_node_states = self.start_state.state
        if self.problem.interface.coupling is not None:
            expected_node_states = _with_touching_nodes_sliding(self.start_state)
        event, self.target = self._predicted(expected_node_states)
        solved_state = self._equilibrium(self.target, expected_node_states)
        for _ in range(_MOST_PREDICTIONS - 1):
            if not _misses(self.problem, self.start_state, solved_state, event):
                break
            has_opened_or_closed = solved_state.closed != self.start_state.closed
            expected_node_states = _on_its_side(
                self.start_state, solved_state, has_opened_or_closed
            )
            event, self.target = self._predicted(expected_node_states)
            if self.target == solved_state.time:
                break
            solved_state = self._equilibrium(self.target, expected_node_states)
            self.problem.work["events predicted again"] += 1
        if event != "regular":
            time = _exact_time(
                self.problem, self.start_state, self.loads_at, solved_state, event, self.latest_end
            )
            if time != self.target:
                solved_state = self._equilibrium(time, up_to_event(self.start_state, solved_state))
        return event, solved_state

    def _predicted(self, states: States) -> tuple[Event, float]:
        return next_event(self.problem, self.start_state, self.loads_at, self.latest_end, states)

    def _equilibrium(self, time: float, expected: States | None = None) -> InterfaceState:
        """The state at an instant; `expected` are states that its nodes may have."""
        solved, iterations = self.problem.equilibrium(
            self.start_state, time, self.loads_at(time), expected
        )
        self.iterations += iterations
        return solved


def next_event(
    problem: ContactProblem,
    start: InterfaceState,
    loads_at: LoadsAt,
    end: float,
    states: States,
) -> tuple[Event, float]:
    """What happens first up to `end` to the set of touching nodes, and when, by one linear
    prediction.

    Parameters
    ----------
    states
        (n,) that the nodes have on the way. Those that touch are the ones of `start`
    """
    gap = start.gap
    pressure = start.pressure
    loads_at_end = loads_at(end)
    try:
        # nodes that start to slide come to the limit of friction at once
        if states is not start.state:
            _, pressure, _, gap = nodal(problem.values_following(start, start.loads, states))
        values_at_end = problem.values_following(start, loads_at_end, states)
    except SingularSet:
        # one node is left: the upper body rolls over it, to where another touches, and nothing
        # foresees it
        return "regular", end
    _, pressure_at_end, _, gap_at_end = nodal(values_at_end)
    share_to_touch, touching_node = _first_crossing(gap, gap_at_end, ~start.closed)
    share_to_release, leaving_node = _first_crossing(pressure, pressure_at_end, start.closed)
    event: Event = "touch" if share_to_touch <= share_to_release else "release"
    share_of_increment = min(share_to_touch, share_to_release)
    event_node = touching_node if event == "touch" else leaving_node
    if share_of_increment >= 1.0:
        return "regular", end
    if len(start.loads) == 2 and problem.interface.coupling is None:
        normal_load = start.loads[0]
        load_at_end = loads_at_end[0]
        load_at_event = normal_load + share_of_increment * (load_at_end - normal_load)
        if not min(normal_load, load_at_end) < load_at_event < max(normal_load, load_at_end):
            return "regular", end
        distance_at_start = normal_load - load_at_event

        def distance_to_event(time: float) -> float:
            """What P is beyond that of the event."""
            return loads_at(time)[0] - load_at_event

    else:
        # by Q and by tilt nodes meet at constant P too: the gap or the force of the first of them,
        # as the loads go
        distance_at_start = float((gap if event == "touch" else pressure)[event_node])
        _, pressure_rates, _, gap_rates = nodal(problem.rates(states, len(start.loads)))
        rates_of_node = (gap_rates if event == "touch" else pressure_rates)[:, event_node]
        # what does not change must not add its rounding
        rates_of_node = np.where(np.subtract(loads_at_end, start.loads) != 0, rates_of_node, 0.0)

        def distance_to_event(time: float) -> float:
            """The gap, or the force, of the node of the event."""
            return distance_at_start + float(
                np.subtract(loads_at(time), start.loads) @ rates_of_node
            )

    time = zero_between(distance_to_event, start.time, end, share_of_increment, distance_at_start)
    return (event, time) if start.time < time < end else ("regular", end)


def _with_touching_nodes_sliding(start: InterfaceState) -> States:
    """(n,) states; nodes that stick without pressure, as they have just touched, slide as the
    neighbour that bears pressure does; those of `start` where nothing would stick.
    """
    just_touched = (start.state == STICK) & (start.pressure <= ROUNDING)
    if not just_touched.any():
        return start.state
    states = start.state.copy()
    for node in np.flatnonzero(just_touched).tolist():
        neighbours = start.state[max(node - 1, 0) : node + 2]
        sliding = neighbours[neighbours > STICK]
        if len(sliding):
            states[node] = sliding[0]
    return states if np.any(states == STICK) else start.state


def _misses(
    problem: ContactProblem, start: InterfaceState, solved: InterfaceState, event: Event
) -> bool:
    """Whether an increment of unlike bodies to `solved` misses its event: another node meets one
    before the increment ends, or no node meets the one that was predicted.
    """
    if problem.interface.coupling is None:
        return False
    is_at_event = _marginal(solved)
    is_too_far = ((solved.closed != start.closed) & ~is_at_event).any()
    meets_expected = is_at_event & (start.closed == (event == "release"))
    is_too_short = event != "regular" and not meets_expected.any()
    return bool(is_too_far or is_too_short)


def _exact_time(
    problem: ContactProblem,
    start: InterfaceState,
    loads_at: LoadsAt,
    solved: InterfaceState,
    event: Event,
    end: float,
) -> float:
    """When the event that `solved` meets to `_LANDED` is met to rounding: nodes that start or end
    to slide bend the way to it.
    """
    meets_event = _marginal(solved) & (start.closed == (event == "release"))
    distances_to_event = np.where(
        meets_event, np.where(solved.closed, solved.pressure, solved.gap), 0.0
    )
    node = int(np.argmax(np.abs(distances_to_event)))
    if abs(distances_to_event[node]) <= _MET:
        return solved.time
    _, pressure_rates, _, gap_rates = nodal(problem.rates(solved.state, len(solved.loads)))
    rates_of_node = (pressure_rates if solved.closed[node] else gap_rates)[:, node]

    def distance_at(time: float) -> float:
        return float(
            distances_to_event[node] + np.subtract(loads_at(time), solved.loads) @ rates_of_node
        )

    duration = solved.time - start.time
    share_of_increment = duration / (end - start.time)
    time = zero_between(distance_at, start.time, end, share_of_increment, distance_at(start.time))
    return time if abs(time - solved.time) < _LARGEST_MOVE * duration else solved.time


def _first_crossing(values_before: Array, values_after: Array, nodes: Mask) -> tuple[float, int]:
    """The share of an increment at which the first of `nodes` goes from a positive value to a
    negative one, linearly, and that node; 1 and -1 if none does.
    """
    falling_nodes = (nodes & (values_before > ROUNDING) & (values_after < -ROUNDING)).nonzero()[0]
    if not len(falling_nodes):
        return 1.0, -1
    shares = values_before[falling_nodes] / (
        values_before[falling_nodes] - values_after[falling_nodes]
    )
    number_of_first = int(shares.argmin())
    return float(shares[number_of_first]), int(falling_nodes[number_of_first])


def up_to_event(start: InterfaceState, solved: InterfaceState) -> States:
    """(n,) solved states, nodes that are at their event on the side where they have been: within
    rounding the law takes either.

    A node that let go in its increment has slid for all of it, and one labelled open would lose the
    friction work.
    """
    changed = _marginal(solved) & (solved.closed != start.closed)
    return _on_its_side(start, solved, changed) if changed.any() else solved.state


def _on_its_side(
    start: InterfaceState, solved: InterfaceState, has_opened_or_closed: Mask
) -> States:
    """(n,) states of `solved`; nodes that have opened or closed get the state that they had on
    the way: open, stuck, or sliding as they have moved since `start`.
    """
    slip = solved.slip - start.slip
    sliding = np.where(slip > ROUNDING, SLIP_FORWARD, SLIP_REVERSE)
    closed_until_now = np.where(np.abs(slip) > ROUNDING, sliding, STICK)
    states_until_now = np.where(start.closed, closed_until_now, OPEN)
    return freeze(np.where(has_opened_or_closed, states_until_now, solved.state), np.int8)


def _marginal(state: InterfaceState) -> Mask:
    """Nodes that are at an event: neither gap nor force but for rounding."""
    return (np.abs(state.gap) <= _LANDED) & (np.abs(state.pressure) <= _LANDED)


def landed(state: InterfaceState, event: Event) -> InterfaceState:
    """`state` with the nodes of the event on their new side: a touching node sticks from here on, a
    released one is open.
    """
    if event == "regular":
        return state
    new = STICK if event == "touch" else OPEN
    return replace(state, state=freeze(np.where(_marginal(state), new, state.state), np.int8))
