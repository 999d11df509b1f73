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

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal, NamedTuple

import numpy as np
import scipy

from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState, nodal_values
from halfplane_fe.energy import work_by_kinks
from halfplane_fe.law import slip_sign, step_errors
from halfplane_fe.path import Stretch, is_straight, scaled_loads, time_of_zero
from halfplane_fe.systems import SingularSet
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, ConvergenceError, read_only_copy
from scenes.array_types import Array, Mask, States

Event = Literal["regular", "touch", "release"]
"""What ends an increment: an open node touches, a closed one is released (lets go), or neither, at
a regular instant.
"""

LoadsAt = Callable[[float], tuple[float, ...]]

# Gap and nodal force within which a node is at an event, scaled.
_TOLERANCE_OF_EVENT = 1e-9
# The same within which the end of the increment is not moved any more to meet the event,
_ROUNDING_OF_EVENT = 1e-14
# and share of the increment by which its end may move for that.
_LARGEST_MOVE = 1e-3
# Share of a regular increment below which a failure is passed on, and a step error accepted (and
# counted), instead of halved.
_SHORTEST_SHARE = 2.0**-12
_SHORTEST_SHARE_FOR_ERROR = 2.0**-5
# Share of an increment's step error that its half has at least where the interface jumps (elsewhere
# a quarter).
_SHARE_OF_ERROR_AT_JUMP = 0.9
# Jumps of a run that has an answer: nine at most in those of the first 200 random loops that are
# between unlike bodies, but for loop 89.
_MOST_JUMPS = 12
_MESSAGE_ON_JUMPS = (
    "contact: the interface jumped from one solution to another in {count} increments, the last at"
    " time {time:.6g}, however short they are; mesh the softer body as finely as the other one"
    " (upper_ratio)"
)
# Predictions of an event of unlike bodies, each with the sliding nodes that the one before has led
# to: the second one meets it, but where it meets another node first.
_MOST_PREDICTIONS = 5
# Instants of an increment at which the end of a stroke is looked for, and the share of it to which
# that is found: slip rests there, so that its square counts.
_N_INSTANTS_OF_STROKE = 9
_TOLERANCE_OF_STROKE = 1e-5
# Share of the step tolerance that may be lost of the friction work by slip that ends within an
# increment. The shear that it leaves moves edges and U. With all of the tolerance, and bulk stress
# out of phase with Q, U was up to 13 times as wrong as stated; with this share 0.4 times. It is
# times the share of the losing nodes in the slip by Q, weighted by p: near sliding they hold back
# all others. Without that, W of such a scene on the default mesh was 5 times as wrong as stated.
_LOST_WORK_ALLOWED = 0.03
# Trials of a regular increment: all of its halves down to the shortest and as many refused.
_MOST_TRIALS = 2**14
# Events of a contact node in a regular increment.
_MOST_EVENTS_PER_NODE = 8


@dataclass(frozen=True)
class StepTolerance:
    """Errors of the dissipation with which an increment is accepted.

    Attributes
    ----------
    error_rate
        the largest error of an increment over its duration, scaled
    kinks_bound_error
        whether the error of an increment is at most the friction work by kinks of pressure and
        slip where nodes start to slide (`energy.work_by_kinks`): so it is of like bodies, whose
        pressure does not depend on what slides. Else it is the bound of `law.step_errors`
    """

    error_rate: float
    kinks_bound_error: bool = False


@dataclass(frozen=True, eq=False)
class Increment:
    """One increment: the state that it leaves behind, and how it was found.

    Attributes
    ----------
    state
        at its end
    solved_states
        (n,) states of the nodes that were solved for. They differ from those of `state` at
        events only: there a node that touches or lets go changes its state at the very end
    step_error
        see `law.step_errors`
    iterations
        of the active set
    event
        what the increment ends with
    """

    state: InterfaceState
    solved_states: States
    step_error: float
    iterations: int
    event: Event


class NotConverged(NamedTuple):
    """An increment that does not converge, tried to this instant."""

    time: float


def increments_along(
    problem: ContactProblem,
    state: InterfaceState,
    stretch: Stretch,
    units: tuple[float, ...],
    tolerance: StepTolerance,
) -> Iterator[Increment]:
    """Solve a contact along one stretch of the load path and yield its increments, each from the
    state that the one before left behind.

    A stretch is a part of the path between turning points of the loads, with the instants at which
    its regular increments end. Increments end earlier where a node touches or lets go, so that no
    node is closed for a part of an increment only. They also end where a stroke of slip (in one
    direction) ends: under prescribed movements, and on curved paths. An increment that does not
    converge, or whose step error is above the tolerance, is halved. The step error is a bound of
    the error that the finite increment makes in the friction work.

    The shortest increments are accepted with a larger step error, and counted. Between unlike
    bodies halving may not lessen the error: the interface jumps from one solution to another, and
    the increment is accepted.

    Parameters
    ----------
    problem
        the contact problem, scaled, in whose `work_counts` the increments are counted
    state
        from which the first increment starts
    stretch
        part of the load path, in the units of the scene: its segment of the path, its start, and
        the instants at which regular increments end
    units
        what each load is divided by
    tolerance
        step error with which an increment is accepted

    Yields
    ------
    Increment
        With the contact state at its end, the states of the nodes that were solved for, its step
        error, its number of iterations, and its event: "touch", "release" or "regular".

    Raises
    ------
    ConvergenceError
        Where halving does not help, the interface jumps too often, or events do not end.
    """

    @cache
    def loads_at(time: float) -> tuple[float, ...]:
        """Scaled loads at an instant."""
        return scaled_loads(stretch.segment, time, units)

    # A node that slides in the first part of an increment alone loses this slip: the increment does
    # not count it. On a straight segment loads change in proportion, and no node turns round within
    # an increment: lost slip is looked for on curved ones alone.
    is_curved = not is_straight(stretch.segment)
    regular_duration = stretch.ends[0] - stretch.start
    # Increments are halved down to 1/4096 of the regular one where they do not converge, and down
    # to 1/32 of it for the step error.
    shortest_duration = _SHORTEST_SHARE * regular_duration
    for end in stretch.ends:
        # Compares step errors with the tolerance: increments that it refuses are halved.
        error_control = _ErrorControl(
            problem, tolerance, _SHORTEST_SHARE_FOR_ERROR * regular_duration
        )
        # Instants still to be reached, the next one last. The first entry is `end`; those after it
        # come by halving, or are instants at which slip ends.
        instants_to_reach = [end]
        # as many trials as halving, and eight events of each node, need at most
        for _ in range(_MOST_TRIALS + _MOST_EVENTS_PER_NODE * len(problem.initial_gap)):
            # Solve up to the first event; where that does not converge, half of the way.
            latest_end = _end_by_turn_of_slip(problem, state, loads_at, instants_to_reach[-1])
            attempt = _attempted_increment(problem, state, loads_at, latest_end, shortest_duration)
            if isinstance(attempt, NotConverged):
                instants_to_reach.append((state.time + attempt.time) / 2)
                continue

            # Shorten it where slip ends within it, or its step error is too large.
            earlier_end = _end_of_slip_within(
                problem, state, attempt, loads_at, error_control, is_curved=is_curved
            )
            if earlier_end is None and not error_control.accepts_increment(attempt, state):
                earlier_end = state.time + (attempt.state.time - state.time) / 2
            if earlier_end is not None:
                instants_to_reach.append(earlier_end)
                continue

            # Accept it, and go on from the state at its end.
            state = attempt.state
            problem.work_counts[f"{attempt.event} increments"] += 1
            yield attempt
            while instants_to_reach and state.time >= instants_to_reach[-1]:
                instants_to_reach.pop()
            if not instants_to_reach:
                break
        else:
            raise ConvergenceError(
                f"the increment that ends at time {end:.6g} was not reached: nodes touch and let go"
                " without end"
            )


def _end_by_turn_of_slip(
    problem: ContactProblem, start_state: InterfaceState, loads_at: LoadsAt, latest_end: float
) -> float:
    """Latest instant at which the next increment may end: `latest_end`, or before it where the slip
    of the nodes that slide at its start is largest, because prescribed movements turn round.

    The slip is the sum over these nodes, each weighted by its pressure and counted in its
    direction of sliding. It is predicted as if every node went on sliding, sticking or being open.

    `latest_end` is returned

    - where it is the instant of largest slip, or that lies in the first eighth of the time to it;
    - where no node slides, or so few nodes hold that the bodies are free to move;
    - where loads are prescribed. Between like half-planes slip then ends at turning points of
      Q - f P or Q + f P, at which increments end anyway. In other bodies it ends a little earlier
      or later, which is looked for when the increment is solved.

    Parameters
    ----------
    problem
        the contact problem, whose `actuators` may prescribe movements; its `rates` are derivatives
        of the values of all nodes by loads and movements while each node sticks, slides or is
        apart as given, (n_loads, 3 + 4 n)
    start_state
        start of the increment: its instant `time`, which nodes slide forward or in reverse
        (`node_states`), and their `pressure` (n,)
    loads_at
        function of an instant: the scaled loads, or movements in their place, (n_loads,)
    latest_end
        latest end of the increment
    """
    if not problem.actuators.prescribe_movements:
        return latest_end
    # +1 or -1 of nodes that slide forward or in reverse, 0 of others, (n,)
    slip_directions = slip_sign(start_state.node_states)
    if not slip_directions.any():
        return latest_end

    # Derivatives of the nodal slip (n_loads, n); those of pressure, shear and gap are not needed.
    try:
        slip_by_loads, _, _, _ = nodal_values(
            problem.rates(start_state.node_states, len(start_state.loads))
        )
    except SingularSet:  # so few nodes hold that the bodies are free to move
        return latest_end
    weighted_slip_by_loads = slip_by_loads @ (slip_directions * start_state.pressure)

    # Instant of the largest weighted slip, among nine and between them.
    instant_of_most_slip = _instant_of_most_slip(
        start_state, loads_at, latest_end, weighted_slip_by_loads
    )
    # _N_INSTANTS_OF_STROKE: nine instants from start to latest end, eighths of the time apart
    end_of_first_eighth = start_state.time + (latest_end - start_state.time) / (
        _N_INSTANTS_OF_STROKE - 1
    )
    return instant_of_most_slip if instant_of_most_slip > end_of_first_eighth else latest_end


def _instant_of_most_slip(
    start_state: InterfaceState, loads_at: LoadsAt, end: float, weighted_slip_by_loads: Array
) -> float:
    """Instant between `start_state` and `end` at which a weighted sum of nodal slips is largest: to
    1e-5 of the time between, or `end` where it grows up to there. The sum is linear in the loads.

    It is bracketed among nine equally spaced instants, then found by bounded minimisation of its
    negative. `weighted_slip_by_loads` (n_loads,) are its derivatives by the loads, and `loads_at`
    gives the scaled loads at an instant.
    """

    def weighted_slip(time: float) -> float:
        """Weighted sum of nodal slips at an instant, minus that at the start."""
        return float(np.subtract(loads_at(time), start_state.loads) @ weighted_slip_by_loads)

    times = np.linspace(start_state.time, end, _N_INSTANTS_OF_STROKE)
    index_of_largest = int(np.argmax([weighted_slip(time) for time in times.tolist()]))
    if index_of_largest == _N_INSTANTS_OF_STROKE - 1:
        return end
    # _TOLERANCE_OF_STROKE: 1e-5
    minimum = scipy.optimize.minimize_scalar(
        lambda time: -weighted_slip(time),
        bounds=(times[max(index_of_largest - 1, 0)], times[index_of_largest + 1]),
        method="bounded",
        options={"xatol": _TOLERANCE_OF_STROKE * (end - start_state.time)},
    )
    return float(minimum.x)


def _end_of_lost_slip(
    problem: ContactProblem,
    start_state: InterfaceState,
    increment: Increment,
    loads_at: LoadsAt,
    tolerance: StepTolerance,
) -> float:
    """Instant at which an increment is to end because slip ends there that it would lose, that is,
    not count. Its own end where the friction work so lost is small.

    Between like half-planes all slip ends where Q - f P or Q + f P turns round, and there
    increments end. In other bodies slip ends a little earlier or later, in one node after the
    other. A node that slides in the first part of an increment and sticks in the rest of it is
    solved as sticking throughout, or as sliding less far than it has.

    Slip of nodes that turn round ends where it is largest, each weighted by its pressure. Of nodes
    that are only stopped by others the instant is unknown: the middle of the increment is taken.
    Small is at most 0.03 of the step tolerance, times the share of the losing nodes in the slip by
    Q of all sliding nodes, weighted likewise.

    Parameters
    ----------
    problem
        the contact problem; its `rates` are derivatives of the values of all nodes by the loads at
        given node states, (n_loads, 3 + 4 n)
    start_state
        state before the increment; its sliding nodes are taken to go on sliding
    increment
        as it was solved, from `start_state` on; its `state` is that at its end
    loads_at
        function of an instant: the scaled loads
    tolerance
        its `error_rate` is the tolerated step error over the duration of an increment
    """
    end = increment.state.time
    directions = slip_sign(start_state.node_states)  # 1 forward, -1 in reverse, 0 without slip
    if not directions.any() or not math.isfinite(tolerance.error_rate):
        return end
    # Derivatives of the nodal slip by P, Q and the other loads, (n_loads, n).
    try:
        slip_by_loads, _, _, _ = nodal_values(
            problem.rates(start_state.node_states, len(start_state.loads))
        )
    except SingularSet:  # so few nodes hold that the bodies are free to move
        return end
    has_turned = _has_turned_at_end(start_state, end, loads_at, slip_by_loads)
    lost_slip = _lost_slip(start_state, increment, loads_at, slip_by_loads, has_turned)
    lost_work = problem.friction * start_state.pressure * lost_slip
    if not lost_work.any():
        return end

    losing_share = _share_of_losing_nodes(start_state, slip_by_loads, lost_work > 0)
    # _LOST_WORK_ALLOWED: 0.03
    allowed_loss = _LOST_WORK_ALLOWED * tolerance.error_rate * (end - start_state.time)
    if not lost_work.sum() > losing_share * allowed_loss:
        return end
    if not lost_work[has_turned].any():
        return (start_state.time + end) / 2

    # Instant at which the slip of the turned nodes, each weighted by its pressure, is largest.
    is_turned_and_losing = has_turned & (lost_work > 0)
    signed_pressure_of_turned = np.where(
        is_turned_and_losing, directions * start_state.pressure, 0.0
    )
    return _instant_of_most_slip(
        start_state, loads_at, end, slip_by_loads @ signed_pressure_of_turned
    )


def _lost_slip(
    start_state: InterfaceState,
    increment: Increment,
    loads_at: LoadsAt,
    slip_by_loads: Array,
    has_turned: Mask,
) -> Array:
    """Slip (n,) that the nodes lose in an increment: slip in the first part of it, which the
    increment does not count as it is solved. 0 of nodes that neither turn round nor are stopped.

    Nodes are stopped that stick in the solved increment though the rates of its start keep them
    sliding: others have changed between open, stick and slip within it, at an unknown instant.

    Parameters
    ----------
    start_state, increment
        state of the interface (its instant, loads, slip and open, stick or slip of its nodes)
        before the increment; and the increment as it was solved
    loads_at
        function of an instant: the scaled loads
    slip_by_loads
        (n_loads, n) derivatives of the slip by the loads, while the nodes stick or slide as at the
        start
    has_turned
        (n,) nodes that slide at the start and would slide the other way at the end
    """
    is_sliding = slip_sign(start_state.node_states) != 0
    has_stopped = is_sliding & (increment.solved_states == STICK) & ~has_turned
    is_losing = has_turned | has_stopped
    if not is_losing.any():
        return np.zeros(len(is_losing))
    end_state = increment.state  # of the interface
    # of all nodes that slide at the start; lost is that of those which turn round or are stopped
    uncounted_slip = _uncounted_slip(start_state, end_state, loads_at, slip_by_loads)
    return np.where(is_losing, uncounted_slip, 0.0)


def _share_of_losing_nodes(
    start_state: InterfaceState, slip_by_loads: Array, is_losing: Mask
) -> float:
    """Share of the nodes that lose slip (`is_losing`, (n,)) in the slip by Q of all sliding nodes,
    each weighted by its pressure: near gross sliding all others lose slip in the same proportion.

    `start_state` has states and pressure of the nodes, `slip_by_loads` (n_loads, n) the derivatives
    of their slip by P, Q and the other loads.
    """
    slip_by_q = slip_by_loads[1]
    is_sliding = slip_sign(start_state.node_states) != 0
    weighted_slip_by_q = np.where(is_sliding, start_state.pressure * np.abs(slip_by_q), 0.0)
    return float(weighted_slip_by_q[is_losing].sum() / weighted_slip_by_q.sum())


def _has_turned_at_end(
    start_state: InterfaceState, end: float, loads_at: LoadsAt, slip_by_loads: Array
) -> Mask:
    """Which nodes slide at the start of an increment and would slide the other way shortly before
    its end, in the last eighth of it, (n,).

    Parameters
    ----------
    start_state
        state before the increment
    end
        instant at its end
    loads_at
        function of an instant: the scaled loads
    slip_by_loads
        (n_loads, n) derivatives of the slip by the loads, while the nodes keep their states from
        the start
    """
    # _N_INSTANTS_OF_STROKE: 9
    shortly_before_end = end - (end - start_state.time) / (_N_INSTANTS_OF_STROKE - 1)
    slip_shortly_before_end = (
        np.subtract(loads_at(end), loads_at(shortly_before_end)) @ slip_by_loads
    )
    return np.asarray(slip_sign(start_state.node_states) * slip_shortly_before_end < 0)


def _uncounted_slip(
    start_state: InterfaceState,
    end_state: InterfaceState,
    loads_at: LoadsAt,
    slip_by_loads: Array,
) -> Array:
    """Slip of each node that an increment does not count, (n,), in the sense in which the node
    slides at the start. It is the farthest slip at nine instants, minus that from the start to the
    end.

    Parameters
    ----------
    start_state, end_state
        states before and after the increment
    loads_at
        function of an instant: the scaled loads
    slip_by_loads
        (n_loads, n) derivatives of the slip by the loads, while the nodes keep their states from
        the start
    """
    directions = slip_sign(start_state.node_states)
    times = np.linspace(start_state.time, end_state.time, _N_INSTANTS_OF_STROKE)
    changes_of_loads = np.subtract([loads_at(time) for time in times.tolist()], start_state.loads)
    predicted_slip = directions * (changes_of_loads @ slip_by_loads)
    counted_slip = np.maximum(directions * (end_state.slip - start_state.slip), 0.0)
    return np.maximum(predicted_slip.max(axis=0) - counted_slip, 0.0)


def _end_of_slip_within(
    problem: ContactProblem,
    start_state: InterfaceState,
    increment: Increment,
    loads_at: LoadsAt,
    error_control: _ErrorControl,
    *,
    is_curved: bool,
) -> float | None:
    """Instant within an increment at which slip ends that the increment does not count, so that it
    is to end there. None where it need not: where little work is lost, where the increment up to
    there would be too short to be halved for its step error, and on straight segments of the path.

    Parameters
    ----------
    problem
        the contact problem, in whose `work_counts` increments that end where slip ends are counted
    start_state, increment
        state before the increment, and the increment as it was solved
    loads_at
        function of an instant: the scaled loads
    error_control
        tolerance of the step error, and shortest duration down to which increments are halved
    is_curved
        whether the segment of the load path is curved
    """
    if not is_curved:
        return None
    end_of_slip = _end_of_lost_slip(
        problem, start_state, increment, loads_at, error_control.tolerance
    )
    is_long_enough = end_of_slip - start_state.time > error_control.shortest_duration
    if not (is_long_enough and end_of_slip < increment.state.time):
        return None
    problem.work_counts["increments ended where slip ends"] += 1
    return end_of_slip


@dataclass
class _ErrorControl:
    """Control of the step error of the increments up to one regular instant.

    Attributes
    ----------
    problem
        the contact problem, in whose `work_counts` refused increments are counted
    tolerance
        of the step error
    shortest_duration
        increments up to that duration are not halved
    refused_start, refused_error
        instant at which the increment started that was refused last, and its error
    has_jumped
        whether the interface has jumped on the way to that instant, so that halving does not help
    """

    problem: ContactProblem
    tolerance: StepTolerance
    shortest_duration: float
    refused_start: float = np.nan
    refused_error: float = np.inf
    has_jumped: bool = False

    def accepts_increment(self, increment: Increment, start_state: InterfaceState) -> bool:
        """Whether an increment from `start_state` is accepted; if not, it is to be halved.

        It is accepted where the error of its friction work is within the tolerance, in proportion
        to its duration. It is accepted too where it is too short to be halved, or the interface has
        jumped: then it is counted. The interface jumps, between unlike bodies, where half of a
        refused increment has nearly the error of the whole increment.

        `kinks_bound_error` is whether that error is at most the friction work by kinks of pressure
        and slip where nodes start to slide, as of like bodies. `refused_start` and `refused_error`
        are the start and the error of the increment that was refused last. `has_jumped`: halving
        does not help any more. Counts are in `problem.work_counts`.

        Raises
        ------
        ConvergenceError
            Where the interface jumps too often on the path.
        """
        duration = increment.state.time - start_state.time
        allowed_error = self.tolerance.error_rate * duration
        work_error = increment.step_error
        if not work_error > allowed_error:
            return True

        # A sharper bound of like bodies; of unlike ones a jump where the error falls by less than
        # a tenth.
        if self.tolerance.kinks_bound_error:
            work_error = min(
                work_error,
                work_by_kinks(self.problem, start_state, increment.state, increment.solved_states),
            )
            if not work_error > allowed_error:
                return True
        # Not of like bodies: they have one solution, and half an increment may have all the kinks.
        elif (
            self.refused_start == start_state.time
            and work_error > _SHARE_OF_ERROR_AT_JUMP * self.refused_error
        ):
            self._count_jump(start_state.time)

        work_counts = self.problem.work_counts
        if duration > self.shortest_duration and not self.has_jumped:
            self.refused_start = start_state.time
            self.refused_error = work_error
            work_counts["increments halved, step error"] += 1
            return False
        work_counts["increments above the step tolerance"] += 1
        return True

    def _count_jump(self, time: float) -> None:
        """Count a jump of the interface from one solution to another, at an instant;
        ConvergenceError beyond 12 jumps on a path.
        """
        self.has_jumped = True
        self.problem.n_jumps += 1
        self.problem.work_counts["increments that jump"] += 1
        if self.problem.n_jumps > _MOST_JUMPS:
            raise ConvergenceError(_MESSAGE_ON_JUMPS.format(count=self.problem.n_jumps, time=time))


def _attempted_increment(
    problem: ContactProblem,
    start_state: InterfaceState,
    loads_at: LoadsAt,
    latest_end: float,
    shortest_duration: float,
) -> Increment | NotConverged:
    """Increment from `start_state` to the first event (a node touches or lets go), or to the
    instant `latest_end` if none comes before; `NotConverged` with the instant tried, if it does not
    converge.

    Parameters
    ----------
    problem
        the contact problem, scaled; increments that do not converge are counted in its
        `work_counts`
    start_state
        state before the increment
    loads_at
        function of an instant: the scaled loads
    latest_end
        latest end of the increment
    shortest_duration
        of an increment that is tried again with a shorter one

    Returns
    -------
    Increment or NotConverged
        The increment has its state after the event, in which nodes that have let go are open, and
        nodes that touch stick; the node states before it; and its step error: the bound of the
        error that its finite size makes in the friction work, 0 where no node changes its state.

    Raises
    ------
    ConvergenceError
        If an increment shorter than `shortest_duration` does not converge.
    """
    # the search for the first event, and for the equilibrium there
    trial = _Trial(problem, start_state, loads_at, latest_end)
    try:
        event, end_state = trial.event_and_state()
    except ConvergenceError:
        if trial.predicted_time - start_state.time < shortest_duration:
            raise
        problem.work_counts["increments halved, not converged"] += 1
        return NotConverged(trial.predicted_time)

    solved_states = states_up_to_event(start_state, end_state)
    step_error = 0.0
    if not np.array_equal(solved_states, start_state.node_states):
        slip_change, pressure_change, _, _ = nodal_values(end_state.values - start_state.values)
        step_error = float(
            step_errors(
                problem.friction,
                pressure_change,
                slip_change,
                start_state.node_states,
                solved_states,
            )
        )
    state = state_after_event(replace(end_state, node_states=solved_states), event)
    return Increment(state, solved_states, step_error, trial.iterations, event)


@dataclass
class _Trial:
    """Search for the end of one increment: the event that ends it, and its instant.

    Attributes
    ----------
    problem
        the contact problem
    start_state
        state of the interface at the start of the increment
    loads_at
        the scaled loads at an instant
    latest_end
        instant at which the increment ends at the latest
    predicted_time
        instant of the event that was predicted last; NaN before the first prediction
    iterations
        number of iterations of the active set so far
    """

    problem: ContactProblem
    start_state: InterfaceState
    loads_at: LoadsAt
    latest_end: float
    predicted_time: float = np.nan
    iterations: int = 0

    def event_and_state(self) -> tuple[Event, InterfaceState]:
        """The event that the increment ends with, and the state of the interface at that instant.

        The event is "touch" where an open node touches, "release" where a closed one lets go. It is
        "regular" where neither happens up to the latest end, at which the increment then ends.

        Event and instant are predicted with the states (open, stick, slip) that the nodes are
        expected to have on the way. Where a prediction misses the event, it is repeated with the
        states that came out, a few times at most. The instant of "touch" or "release" is then found
        to round-off, and the state is solved for there. Between like bodies
        (`interface.coupling` is None: pressure does not depend on shear) the first prediction is
        exact.

        Raises
        ------
        ConvergenceError
            If the active set does not converge.
        """
        # First prediction, and the solution at the predicted instant (`self.predicted_time`).
        expected_node_states = self.start_state.node_states
        if self.problem.interface.coupling is not None:
            expected_node_states = _with_touching_nodes_sliding(self.start_state)
        event, self.predicted_time = self._predicted_event(expected_node_states)
        solved_state = self._equilibrium(self.predicted_time, expected_node_states)

        # Further predictions while the event is missed, five in all.
        for _ in range(_MOST_PREDICTIONS - 1):
            if not _misses_event(self.problem, self.start_state, solved_state, event):
                break
            has_opened_or_closed = solved_state.is_closed != self.start_state.is_closed
            expected_node_states = _states_before_event(
                self.start_state, solved_state, has_opened_or_closed
            )
            event, self.predicted_time = self._predicted_event(expected_node_states)
            if self.predicted_time == solved_state.time:
                break
            solved_state = self._equilibrium(self.predicted_time, expected_node_states)
            self.problem.work_counts["events predicted again"] += 1

        # The instant to round-off.
        if event != "regular":
            time_of_event = _time_of_event(
                self.problem, self.start_state, self.loads_at, solved_state, event, self.latest_end
            )
            if time_of_event != self.predicted_time:
                solved_state = self._equilibrium(
                    time_of_event, states_up_to_event(self.start_state, solved_state)
                )
        return event, solved_state

    def _predicted_event(self, node_states: States) -> tuple[Event, float]:
        """First event (touch, release or regular end of the increment) and its instant, if the
        nodes have these `node_states` (n,) on the way.
        """
        return next_event(
            self.problem, self.start_state, self.loads_at, self.latest_end, node_states
        )

    def _equilibrium(self, time: float, expected_node_states: States) -> InterfaceState:
        """State of the interface in equilibrium at an instant; `expected_node_states` (n,) are
        tried first. The iterations are counted.
        """
        state, iterations = self.problem.equilibrium(
            self.start_state, time, self.loads_at(time), expected_node_states
        )
        self.iterations += iterations
        return state


def next_event(
    problem: ContactProblem,
    start_state: InterfaceState,
    loads_at: LoadsAt,
    latest_end: float,
    node_states: States,
) -> tuple[Event, float]:
    """First event between `start_state` and the instant `latest_end`, and its instant, by one
    linear prediction: an open node touches, or a closed one is released; ("regular", `latest_end`)
    where neither happens before.

    The gap of an open node, and the pressure of a closed one, are linear in the loads while the
    nodes keep their states. The node at which one of these reaches 0 first has the event. Its
    instant then follows from the course of the loads. Where so few nodes hold that the bodies are
    free to move, no event is predicted.

    Parameters
    ----------
    problem
        the contact problem; its `values_following` are approach, U and tilt, then slip, pressure
        and shear (nodal forces) and gap of the nodes, (3 + 4 n,), at other loads
    start_state
        state of the contact before the increment
    loads_at
        function of an instant: the scaled loads
    latest_end
        latest end of the increment
    node_states
        (n,) open, stick or slip that the nodes have on the way; the same ones are open as in
        `start_state`
    """
    # Gap and pressure (n,) at the start and, by linear prediction, at the end.
    gap_at_start = start_state.gap
    pressure_at_start = start_state.pressure
    loads_at_end = loads_at(latest_end)
    try:
        # with new node states both jump: nodes that start to slide have the shear f p at once
        if node_states is not start_state.node_states:
            _, pressure_at_start, _, gap_at_start = nodal_values(
                problem.values_following(start_state, start_state.loads, node_states)
            )
        values_at_end = problem.values_following(start_state, loads_at_end, node_states)
    except SingularSet:
        # One node is left: the upper body rolls over it, to where another touches.
        return "regular", latest_end
    _, pressure_at_end, _, gap_at_end = nodal_values(values_at_end)

    first_event = _first_event(
        (gap_at_start, gap_at_end), (pressure_at_start, pressure_at_end), start_state.is_closed
    )
    if first_event is None:
        return "regular", latest_end

    values_at_start = gap_at_start if first_event.event == "touch" else pressure_at_start
    time_of_event = _time_of_first_event(
        problem,
        start_state,
        loads_at,
        latest_end,
        node_states,
        first_event,
        float(values_at_start[first_event.node]),
    )
    if start_state.time < time_of_event < latest_end:
        return first_event.event, time_of_event
    return "regular", latest_end


def _time_of_first_event(
    problem: ContactProblem,
    start_state: InterfaceState,
    loads_at: LoadsAt,
    latest_end: float,
    node_states: States,
    first_event: _FirstEvent,
    value_at_start: float,
) -> float:
    """Instant of an event that is predicted linearly within an increment; `latest_end` where P does
    not come to the value of the event, or nothing reaches 0.

    Of like bodies under P and Q alone it depends on P: it is where P has the value of the event. In
    other cases nodes also meet by Q and by tilt, at constant P too. Then the gap or pressure of the
    node of the event is followed along the loads, at its rates, to 0.

    Parameters
    ----------
    problem
        the contact problem; its `interface.coupling` (slip by pressure) is None of like bodies
    start_state
        state of the contact before the increment
    loads_at
        function of an instant: the scaled loads
    latest_end
        latest end of the increment
    node_states
        (n,) open, stick or slip that the nodes have on the way
    first_event
        the event, its node, and the share of the increment up to it, linearly
    value_at_start
        gap or pressure of the node at the start of the increment
    """
    loads_at_end = loads_at(latest_end)
    if len(start_state.loads) == 2 and problem.interface.coupling is None:
        normal_load = start_state.loads[0]
        load_at_end = loads_at_end[0]
        load_at_event = normal_load + first_event.share * (load_at_end - normal_load)
        if not min(normal_load, load_at_end) < load_at_event < max(normal_load, load_at_end):
            return latest_end
        distance_at_start = normal_load - load_at_event

        def distance_to_event(time: float) -> float:
            """P minus its value at the event."""
            return loads_at(time)[0] - load_at_event

    else:
        distance_at_start = value_at_start
        rates_of_node = _rates_of_event(
            problem, start_state, loads_at_end, node_states, first_event
        )

        def distance_to_event(time: float) -> float:
            """Gap or pressure of the node of the event."""
            return distance_at_start + float(
                np.subtract(loads_at(time), start_state.loads) @ rates_of_node
            )

    # Where the distance is zero, looked for near the share that the linear prediction gives.
    return time_of_zero(
        distance_to_event, start_state.time, latest_end, first_event.share, distance_at_start
    )


class _FirstEvent(NamedTuple):
    """First event in an increment by linear prediction: "touch" of an open node or "release" of a
    closed one, number of the node, and share of the increment until then.
    """

    event: Event
    node: int
    share: float


def _first_event(
    gaps: tuple[Array, Array], pressures: tuple[Array, Array], is_closed: Mask
) -> _FirstEvent | None:
    """The first open node whose gap becomes negative, or closed one whose pressure does: its event,
    its number, and the share of the increment up to then. None where neither happens before the end
    of the increment.

    Parameters
    ----------
    gaps, pressures
        gap and pressure of the n nodes, (n,) at the start and (n,) at the end of the increment
    is_closed
        (n,) whether each node touches
    """
    gap, gap_at_end = gaps
    pressure, pressure_at_end = pressures
    share_to_touch, touching_node = _first_crossing(gap, gap_at_end, ~is_closed)
    share_to_release, leaving_node = _first_crossing(pressure, pressure_at_end, is_closed)
    if min(share_to_touch, share_to_release) >= 1.0:
        return None
    if share_to_touch <= share_to_release:
        return _FirstEvent("touch", touching_node, share_to_touch)
    return _FirstEvent("release", leaving_node, share_to_release)


def _rates_of_event(
    problem: ContactProblem,
    start_state: InterfaceState,
    loads_at_end: tuple[float, ...],
    node_states: States,
    first_event: _FirstEvent,
) -> Array:
    """Derivatives (n_loads,) by the loads of the gap of a node that touches, or of the pressure of
    one that is released. 0 by loads that do not change in the increment, as these must not add
    their rounding.

    Parameters
    ----------
    problem
        the contact problem; its `rates` are derivatives of the nodal values by the loads
    start_state
        state before the increment, with its loads
    loads_at_end
        scaled loads at the latest end of the increment
    node_states
        (n,) open, stick or slip that the nodes have on the way
    first_event
        event and number of its node
    """
    _, pressure_rates, _, gap_rates = nodal_values(
        problem.rates(node_states, len(start_state.loads))
    )
    rates_of_nodes = gap_rates if first_event.event == "touch" else pressure_rates
    load_changes = np.subtract(loads_at_end, start_state.loads)
    return np.where(load_changes != 0, rates_of_nodes[:, first_event.node], 0.0)


def _with_touching_nodes_sliding(start_state: InterfaceState) -> States:
    """States (n,) of the nodes in `start_state`, but for nodes that have just touched, and so stick
    without pressure: each slides as a sliding neighbour does. Where no node would stick then, all
    are as in `start_state`. States are numbers: 0 open, 1 stick, above that slip.
    """
    # ROUNDING: round-off of scaled forces and displacements, 1e-11
    has_just_touched = (start_state.node_states == STICK) & (start_state.pressure <= ROUNDING)
    if not has_just_touched.any():
        return start_state.node_states
    node_states = start_state.node_states.copy()
    for node in np.flatnonzero(has_just_touched).tolist():
        states_beside = start_state.node_states[max(node - 1, 0) : node + 2]
        sliding_states = states_beside[states_beside > STICK]
        if len(sliding_states):
            node_states[node] = sliding_states[0]
    return node_states if np.any(node_states == STICK) else start_state.node_states


def _misses_event(
    problem: ContactProblem, start_state: InterfaceState, solved_state: InterfaceState, event: Event
) -> bool:
    """Whether an increment from `start_state` to `solved_state` misses the predicted `event`: a
    node touches or lets go before the increment ends, or no node is at the predicted touch or
    release then. For the event "regular" no node has to be at one.

    False of like bodies, where the prediction is exact: their pressure does not depend on shear
    (`interface.coupling` is None). A node is at an event if it has neither gap nor force, to 1e-9.
    """
    if problem.interface.coupling is None:
        return False
    is_at_event = _is_at_event(solved_state)
    is_too_far = ((solved_state.is_closed != start_state.is_closed) & ~is_at_event).any()
    # Nodes open at the start are met at a touch, closed ones at a release.
    meets_event = is_at_event & (start_state.is_closed == (event == "release"))
    is_too_short = event != "regular" and not meets_event.any()
    return bool(is_too_far or is_too_short)


def _time_of_event(
    problem: ContactProblem,
    start_state: InterfaceState,
    loads_at: LoadsAt,
    solved_state: InterfaceState,
    event: Event,
    latest_end: float,
) -> float:
    """Instant of the event that ends an increment, to round-off: there a touching node has no gap,
    or a released one no pressure.

    `solved_state` has the event to 1e-9, since the prediction leaves out that nodes start or end
    sliding. Several nodes may be at it: that with the largest gap or force left counts, and is
    brought to zero by its rate with the loads. The instant of `solved_state` stays where that is
    round-off already, or where the end would move by a thousandth of the increment or more.

    Parameters
    ----------
    problem
        the contact problem; its `rates` are derivatives of the values of all nodes by the loads at
        given node states, (n_loads, 3 + 4 n)
    start_state, solved_state
        states before the increment and at its end
    loads_at
        function of an instant: the scaled loads
    event
        "touch" of an open node, or "release" of a closed one
    latest_end
        latest end of the increment
    """
    # Gap or pressure (n,) of the nodes at the event, 0 of all others.
    meets_event = _is_at_event(solved_state) & (start_state.is_closed == (event == "release"))
    distances_to_event = np.where(
        meets_event, np.where(solved_state.is_closed, solved_state.pressure, solved_state.gap), 0.0
    )
    node = int(np.argmax(np.abs(distances_to_event)))
    # _ROUNDING_OF_EVENT: 1e-14
    if abs(distances_to_event[node]) <= _ROUNDING_OF_EVENT:
        return solved_state.time

    # That node's gap or force follows the loads at its rates, (n_loads,).
    _, pressure_rates, _, gap_rates = nodal_values(
        problem.rates(solved_state.node_states, len(solved_state.loads))
    )
    rates_of_node = (pressure_rates if solved_state.is_closed[node] else gap_rates)[:, node]

    def distance_at(time: float) -> float:
        """Gap or force of that node at an instant."""
        return float(
            distances_to_event[node]
            + np.subtract(loads_at(time), solved_state.loads) @ rates_of_node
        )

    duration = solved_state.time - start_state.time
    share_of_increment = duration / (latest_end - start_state.time)
    time_of_event = time_of_zero(
        distance_at, start_state.time, latest_end, share_of_increment, distance_at(start_state.time)
    )
    # _LARGEST_MOVE: 1e-3 of the increment
    return (
        time_of_event
        if abs(time_of_event - solved_state.time) < _LARGEST_MOVE * duration
        else solved_state.time
    )


def _first_crossing(
    values_before: Array, values_after: Array, is_counted: Mask
) -> tuple[float, int]:
    """Share of an increment up to which the first node goes from a positive gap or pressure to a
    negative one, linearly, and the number of that node; 1 and -1 where none does.

    `values_before` and `values_after` (n,) are gap or pressure at start and end of the increment;
    `is_counted` (n,) are the nodes that are looked at.
    """
    # ROUNDING: round-off of scaled forces and displacements, 1e-11
    falling_nodes = (
        is_counted & (values_before > ROUNDING) & (values_after < -ROUNDING)
    ).nonzero()[0]
    if not len(falling_nodes):
        return 1.0, -1
    shares = values_before[falling_nodes] / (
        values_before[falling_nodes] - values_after[falling_nodes]
    )
    index_of_first_crossing = int(shares.argmin())
    return float(shares[index_of_first_crossing]), int(falling_nodes[index_of_first_crossing])


def states_up_to_event(start_state: InterfaceState, solved_state: InterfaceState) -> States:
    """States (n,) of the nodes on the way of an increment from `start_state` to `solved_state`, up
    to the event at its end: nodes that touch or let go there have the state from before it.

    At the event itself the law may call such a node open or closed, by round-off. One that lets go
    has slid through the increment: counted as open, its friction work would be lost.
    """
    has_changed = _is_at_event(solved_state) & (solved_state.is_closed != start_state.is_closed)
    return (
        _states_before_event(start_state, solved_state, has_changed)
        if has_changed.any()
        else solved_state.node_states
    )


def _states_before_event(
    start_state: InterfaceState, solved_state: InterfaceState, has_opened_or_closed: Mask
) -> States:
    """States (n,) of the nodes in `solved_state`, but for those that have opened or closed since
    `start_state`, a mask (n,). These have the state that they had on the way: open, stick, or slip
    in the sense in which they have moved.
    """
    slip_increment = solved_state.slip - start_state.slip
    # ROUNDING: round-off of scaled forces and displacements, 1e-11
    slip_states = np.where(slip_increment > ROUNDING, SLIP_FORWARD, SLIP_REVERSE)
    states_of_closed_nodes = np.where(np.abs(slip_increment) > ROUNDING, slip_states, STICK)
    states_on_the_way = np.where(start_state.is_closed, states_of_closed_nodes, OPEN)
    return read_only_copy(
        np.where(has_opened_or_closed, states_on_the_way, solved_state.node_states), np.int8
    )


def _is_at_event(state: InterfaceState) -> Mask:
    """Whether each node is at an event, a touch or release, (n,): it has neither gap nor pressure,
    up to 1e-9 in scaled variables.
    """
    return (np.abs(state.gap) <= _TOLERANCE_OF_EVENT) & (
        np.abs(state.pressure) <= _TOLERANCE_OF_EVENT
    )


def state_after_event(state: InterfaceState, event: Event) -> InterfaceState:
    """The state of the interface after an event: nodes without gap and pressure stick from here on
    if the event is a "touch", and are open if it is a "release". After "regular" it is the same
    `state`.
    """
    if event == "regular":
        return state
    state_of_nodes = STICK if event == "touch" else OPEN
    node_states = np.where(_is_at_event(state), state_of_nodes, state.node_states)
    return replace(state, node_states=read_only_copy(node_states, np.int8))
