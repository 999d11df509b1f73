"""A whole load path through the interface: initial loading, then revolutions until the state
repeats.

Shakedown and ratcheting: where a series of one value a revolution goes, and how far from there its
last value is. With P and Q on like bodies the second revolution repeats the first. Unlike bodies
only approach their steady state, and so do loops with bulk stress or tilt out of phase:
geometrically, or as a power of the number k of revolutions. Then a small last change d_k is no
bound of what is left:

    geometric, d_k/d_(k-1) = r:             left = d_k r/(1 - r)
    algebraic, left in proportion to k^-m:     left = d_k/[(k/(k-1))^m - 1], about (k/m) d_k

The number m follows from the last ratio, d_k being about (k - 1/2)^-(m+1): r = ((k - 3/2)/(k -
1/2))^(m+1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from halfplane_fe.between_nodes import (
    EdgesByLoad,
    Excess,
    PassedNodes,
    contact_by_load,
    excess,
    stick_by_load,
)
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.energy import increment_energies, law_violations
from halfplane_fe.law import slip_sign
from halfplane_fe.path import (
    Stretch,
    areas_between_path_and_chords,
    is_straight,
    scaled_loads,
    stretches,
)
from halfplane_fe.reported_states import shear_grows_within_cone, slip_since_stop
from halfplane_fe.stepping import Increment, StepTolerance, increments_along
from scenes import ConvergenceError, Interrupted, LoadPath, LoadSegment, read_only_copy
from scenes.array_types import Array, Indices, Mask, States

Progress = Callable[[int, int | None, str], None]

# Two revolutions end alike when no nodal force differs by more than this share of the largest.
# Nodes at the rim of the permanent stick zone go on creeping towards the steady cycle. How fast is
# another matter (`trend`): the dissipation has to be there too.
LARGEST_CHANGE_OF_REPEAT = 5e-4
# The same where they are equal but for round-off of the nodal forces.
_ROUNDING_OF_CHANGE = 1e-9
# Dissipation over f^2 P^2/E* below which the step error need not follow it down.
_LEAST_DISSIPATION = 3e-3
# Instants of a path of straight segments that keep pressure, shear and gap: a record of 2,000 rows
# has 40,000 increments, which would take gigabytes. No scene of the library comes near.
MOST_COMPLETE_STATES = 4000
# Share of the first segment of the initial loading after which its line of action is read.
_SHARE_OF_FIRST_SEGMENT = 1e-3
# Increments whose energies are found together: few enough that the rates of their states are still
# cached, which are what a path needs most memory for.
_INCREMENTS_PER_BATCH = 32
# Share of the largest value within which two values are the same but for round-off.
_ROUNDING_OF_VALUES = 1e-12
# A ratio of a geometric series stays; that of m = 1 rises by a factor of 1 + 2/[k (k-2)] from one
# revolution to the next. Half-way between the two a series counts as algebraic.
_RISE_OF_RATIO = 1.0
# Steep ends of series look steeper than they are: k^-3 is the steepest that was met.
_STEEPEST_EXPONENT = 3.0
# Slower than k^-1/2 is no trend.
_SLOWEST_EXPONENT = 0.5
# Drift of a revolution over the travel of U up to which it is none.
_LEAST_DRIFT = 1e-3
# Last drift over what its trend leaves, above which it does not vanish: drifts that vanish leave as
# much as themselves, to the trend's own error; those of ratcheting next to nothing.
_DRIFT_RATIO_OF_RATCHETING = 3.0


@dataclass(frozen=True)
class Trend:
    """What is left of a series after its last value.

    Attributes
    ----------
    kind
        "steady" (the last two values are the same to round-off), "geometric", "algebraic", or
        "unclear": fewer than four values, or differences that do not fall
    change_to_limit
        limit minus the last value; of an unclear one k |d_k|, which is a size without a sign,
        or NaN of a single value
    limit
        of the series, NaN of an unclear one
    """

    kind: str
    change_to_limit: float
    limit: float


def trend(values: Sequence[float]) -> Trend:
    """Trend of a quantity with one value a revolution, from its last four values: steady, geometric
    or algebraic, with its limit and the change to it (limit minus last value).

    With d_k the last difference, r its ratio to the one before, m the exponent of the decay k^-m:

        geometric   change = d_k r/(1 - r)
        algebraic   change = d_k/[(k/(k - 1))^m - 1],   r = ((k - 3/2)/(k - 1/2))^(m + 1)

    Steady is where the last two values are equal to round-off. Where there are fewer than four
    values, or no such form fits, the trend is unclear: its limit is NaN, its change k |d_k|, or NaN
    of a single value. `values` are k in number and start at the first revolution, since k counts
    revolutions. m is 3 at most; below 1/2 the trend is unclear.

    >>> trend([5.0, 3.0, 2.5, 2.375]).kind, trend([1.5, 1.25, 1.125, 1.0625])
    ('geometric', Trend(kind='geometric', change_to_limit=-0.0625, limit=1.0))
    """
    # a Trend has its kind, the change to the limit, and the limit
    k = len(values)  # number of revolutions
    if k < 2:
        return Trend("unclear", float("nan"), float("nan"))
    differences = np.diff(values).tolist()
    last_difference = differences[-1]
    # _ROUNDING_OF_VALUES: 1e-12
    if k * abs(last_difference) <= _ROUNDING_OF_VALUES * max(map(abs, values)):
        return Trend("steady", 0.0, values[-1])

    unclear_trend = Trend("unclear", k * abs(last_difference), float("nan"))
    if k < 4 or not all(differences[-3:]):
        return unclear_trend
    ratio_before = differences[-2] / differences[-3]
    ratio = differences[-1] / differences[-2]
    if not (0 < ratio_before < 1 and 0 < ratio < 1):
        return unclear_trend

    # The ratio of a geometric series stays; that of an algebraic one rises towards 1, for m = 1 by
    # the factor 1 + 2/[k (k - 2)]. From half of this rise on (_RISE_OF_RATIO: 1) it is algebraic.
    if ratio <= ratio_before * (1 + _RISE_OF_RATIO / (k * (k - 2))):
        change_to_limit = last_difference * ratio / (1 - ratio)
        return Trend("geometric", change_to_limit, values[-1] + change_to_limit)
    decay_exponent = float(np.log(ratio) / np.log((k - 1.5) / (k - 0.5))) - 1
    # _STEEPEST_EXPONENT: 3; _SLOWEST_EXPONENT: 0.5
    decay_exponent = min(decay_exponent, _STEEPEST_EXPONENT)
    if decay_exponent < _SLOWEST_EXPONENT:
        return unclear_trend
    change_to_limit = last_difference / ((k / (k - 1)) ** decay_exponent - 1)
    return Trend("algebraic", change_to_limit, values[-1] + change_to_limit)


def is_ratcheting(drifts: Sequence[float], travel: float) -> bool:
    """Whether the contact ratchets: the tangential displacement U drifts by as much in each
    revolution, instead of less and less. So it is if the last drift is above three times what it
    would still change by the trend of all drifts. False after a single revolution.

    Parameters
    ----------
    drifts
        change of U from start to end of each revolution
    travel
        largest minus smallest U of the last revolution; a thousandth of it is no drift

    Examples
    --------
    >>> is_ratcheting([0.3, 0.11, 0.1, 0.1], 1.0), is_ratcheting([0.4, 0.2, 0.1, 0.05], 1.0)
    (True, False)
    """
    last_drift = abs(drifts[-1])
    # `change_to_limit` of a series: its limit minus its last value; _DRIFT_RATIO_OF_RATCHETING: 3
    largest_vanishing_drift = _DRIFT_RATIO_OF_RATCHETING * abs(trend(drifts).change_to_limit)
    # _LEAST_DRIFT: 1e-3
    return last_drift > _LEAST_DRIFT * travel and last_drift > largest_vanishing_drift


@dataclass(eq=False)
class _Thinning:
    """Which states of a long path keep pressure, shear and gap of their nodes.

    Attributes
    ----------
    end_number_of_state
        by index of a state at the end of a stretch (at a turning point, a vertex of a polygon or a
        row of a record): the number of such states before it
    index_of_largest_load
        of the state with the largest P
    n_stored
        number of states that keep pressure, shear and gap
    stride
        n of the states between ends of stretches: every n-th of them keeps its values
    stride_of_ends
        n of the states at ends of stretches: every n-th of them keeps its values
    """

    end_number_of_state: dict[int, int] = field(default_factory=dict)
    index_of_largest_load: int = 0
    n_stored: int = 1
    stride: int = 1
    stride_of_ends: int = 1

    def keeps_state(self, index: int) -> bool:
        """Whether the state of this index keeps pressure, shear and gap of its nodes, on a long
        load path: every `stride`-th state does. Of states at ends of stretches (parts of the path
        between turning points) every `stride_of_ends`-th does, by their number in
        `end_number_of_state`.
        """
        if index in self.end_number_of_state:
            return self.end_number_of_state[index] % self.stride_of_ends == 0
        return index % self.stride == 0

    def can_double_a_stride(self, n_states: int) -> bool:
        """Whether fewer states can keep their nodal forces, by doubling one of the two strides:
        every n-th state, n a stride, keeps them. False once a stride is `n_states` or more: then
        only the first state keeps them.
        """
        return max(self.stride, self.stride_of_ends) < n_states

    def double_a_stride(self) -> None:
        """Let half as many states keep their nodal forces: of those at ends of stretches (parts of
        the load path between turning points), or of those between. At most three quarters of the
        states that keep them are at ends.
        """
        if 4 * len(self.end_number_of_state) > 3 * MOST_COMPLETE_STATES * self.stride_of_ends:
            self.stride_of_ends *= 2
        else:
            self.stride *= 2


def _slips_since_stop(states: Sequence[InterfaceState], slip_before: Array | float) -> Array:
    """Distance (k, n) that each node has slipped in its present direction without a stop, after
    each of k increments; with the sign of the slip.

    `states` are the k + 1 contact states around the increments. `slip_before` is that distance
    before the first, (n,), or 0 of all nodes. A node that moves against the sense of slip of its
    state counts as stopped.
    """
    slip = np.diff([state.slip for state in states], axis=0)
    is_sliding = slip * slip_sign(np.stack([state.node_states for state in states[1:]])) > 0
    return slip_since_stop(np.where(is_sliding, slip, 0.0), slip_before)


def _energies_and_checks(
    problem: ContactProblem,
    states: Sequence[InterfaceState],
    solved_by_increment: Sequence[States],
    enclosed_areas: Array | None,
) -> tuple[dict[str, Array], Array]:
    """Energies, works and admissibility checks of k increments by name, (k,) each, scaled; and the
    friction work of the n nodes, (k, n), of which "dissipation" is the sum.

    Parameters
    ----------
    problem
        the contact problem that the states solve
    states
        the k + 1 contact states around the increments
    solved_by_increment
        k arrays (n,): open, stick or slip of the nodes as each increment was solved
    enclosed_areas
        (n_loads, n_loads, k) areas between a curved load path and its chords, by pairs of loads,
        scaled; None where the path is straight
    """
    energies = vars(increment_energies(problem, states, solved_by_increment, enclosed_areas)).copy()
    nodal_work = energies.pop("dissipation")
    friction_work = {"dissipation": nodal_work.sum(axis=1)}
    return law_violations(problem, states) | energies | friction_work, nodal_work


def _enclosed_areas(
    states: Sequence[InterfaceState], segment: LoadSegment | None, load_units: tuple[float, ...]
) -> Array | None:
    """Areas between a curved load path and its chords in k increments, in the plane of each pair of
    loads, (n_loads, n_loads, k), scaled; None on straight segments, where there are none.

    Parameters
    ----------
    states
        the k + 1 contact states around the increments, with their instants
    segment
        curved segment of the load path that they are on; None for a straight one
    load_units
        (5,) what each load is divided by: P, Q, both bulk stresses, tilt or moment
    """
    if segment is None:
        return None
    enclosed_areas = areas_between_path_and_chords(
        segment, np.array([state.time for state in states])
    )
    if enclosed_areas is None:
        return None
    units = load_units[: len(enclosed_areas)]
    return np.asarray(enclosed_areas / np.multiply.outer(units, units)[:, :, None])


@dataclass(eq=False)
class PathRun:
    """States, energies and checks of a load path, as far as it is solved; scaled. The first of
    `states` is the unloaded one.

    A path of straight segments with more than `MOST_COMPLETE_STATES` increments is thinned while it
    is followed: some states lose the pressure, shear and gap of their nodes. Between the rows of
    measured loads every second, fourth, ... state keeps them; of the rows too, where these alone
    are too many.

    Attributes
    ----------
    states
        (n_steps + 1)
    may_thin
        whether states may lose pressure, shear and gap
    places_stick_edges
        whether stick edges are located between nodes; if not, `stick_edges` has none at any instant
    increment_records
        energies and admissibility checks by name, in batches: (k,) of k increments of a curved
        segment, or of straight ones
    iterations
        (n_steps), of each increment
    nodal_work
        (n,) friction work of each node in the revolution so far
    cycle_starts
        index of the state at which each revolution starts
    nodal_work_by_cycle
        per revolution, (n,) friction work of each node; one for the whole path where it is not
        periodic
    edge_excess_by_cycle
        per revolution, the friction work that the mesh adds, since edges of contact and stick
        jump from node to node; with the permanent stick zone
    steady_from
        index of the first revolution that ended as it started, with a friction work closer to its
        limit than it is uncertain
    force_change_by_cycle
        per revolution, largest change of a nodal p or q/f (f < 1) from its start to its end,
        over the largest p
    contact_edges, stick_edges
        by the load, of the first state and of each batch of increments
    slip_since_stop
        (n,) of each node at the last state, in one direction without a stop
    sticks_in_full
        by the shear at both edges of contact (`reported_states.shear_grows_within_cone`), of the
        first state and of each batch of increments
    failure
        what stopped the run, or None
    passed_nodes
        by side (1 on the right of x = 0, -1 on the left), how uncertain the stick edge was between
        the nodes that it has passed, at the last state
    ends_of_stretches
        indices of the states at which the loads may turn round: at turning points of P, Q - f P or
        Q + f P, and at vertices of the path
    """

    states: list[InterfaceState]
    may_thin: bool = False
    places_stick_edges: bool = True
    increment_records: list[dict[str, Array]] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)
    nodal_work: Array = field(default_factory=lambda: np.zeros(0))
    cycle_starts: list[int] = field(default_factory=list)
    nodal_work_by_cycle: list[Array] = field(default_factory=list)
    edge_excess_by_cycle: list[Excess] = field(default_factory=list)
    steady_from: int | None = None
    force_change_by_cycle: list[float] = field(default_factory=list)
    contact_edges: list[EdgesByLoad] = field(default_factory=lambda: [EdgesByLoad.nowhere(1)])
    stick_edges: list[EdgesByLoad] = field(default_factory=lambda: [EdgesByLoad.nowhere(1)])
    slip_since_stop: Array | float = 0.0
    sticks_in_full: list[Mask] = field(default_factory=lambda: [np.zeros(1, dtype=bool)])
    failure: ConvergenceError | Interrupted | None = None
    passed_nodes: dict[int, PassedNodes] = field(
        default_factory=lambda: {-1: PassedNodes(), 1: PassedNodes()}
    )
    ends_of_stretches: list[int] = field(default_factory=list)
    _thinning: _Thinning = field(default_factory=_Thinning)
    _first_of_stretch: int = 0

    def values_of_increments(self, name: str) -> Array:
        """Values of one energy or admissibility check, by its name, of all increments, (n_steps,);
        scaled.
        """
        if not self.increment_records:
            return np.zeros(0)
        return np.concatenate([record[name] for record in self.increment_records])

    @property
    def trend(self) -> Trend:
        """Trend of the friction work W of the revolutions: steady, geometric or algebraic, with its
        limit, and the change to it. Steady too where the last revolution changed no nodal force by
        more than round-off.
        """
        if self.force_change_by_cycle and self.force_change_by_cycle[-1] <= _ROUNDING_OF_CHANGE:
            return Trend("steady", 0.0, float(self.nodal_work_by_cycle[-1].sum()))
        return trend([float(work.sum()) for work in self.nodal_work_by_cycle])

    @property
    def last_revolution_failed(self) -> bool:
        """Whether the last revolution was begun and not completed."""
        return len(self.force_change_by_cycle) < len(self.cycle_starts)

    @property
    def ratchets(self) -> bool:
        """Whether the contact ratchets: each revolution leaves the upper body further along by the
        same distance, so that the tangential displacement U (`shift` of a state) grows without end.

        `cycle_starts` are indices of the states at which revolutions start; none where the path
        does not repeat. `force_change_by_cycle` has, of each revolution that was completed, the
        largest change of a nodal force from its start to its end, over the largest one.
        """
        path_repeats = bool(self.cycle_starts)
        if not path_repeats or self.last_revolution_failed:
            return False
        ends_of_cycles = [*self.cycle_starts, len(self.states) - 1]
        drifts = np.diff([self.states[index].shift for index in ends_of_cycles]).tolist()
        # Where the last revolution is steady to round-off, the next ones drift as much as it does.
        # _ROUNDING_OF_CHANGE: 1e-9
        if self.force_change_by_cycle[-1] <= _ROUNDING_OF_CHANGE:
            drifts = [drifts[-1], drifts[-1]]
        last_cycle = self.states[self.cycle_starts[-1] :]
        travel = float(np.ptp([state.shift for state in last_cycle]))
        return is_ratcheting(drifts, travel)

    @property
    def stored_indices(self) -> Indices:
        """Indices of the states with pressure, shear and gap, the first and the last among them."""
        return np.flatnonzero([state.is_complete for state in self.states])

    def append(
        self,
        problem: ContactProblem,
        increments: Sequence[Increment],
        segment: LoadSegment | None,
        load_units: tuple[float, ...],
    ) -> None:
        """Append solved increments to the run, with their energies, admissibility checks and
        friction work; all of them or, where Ctrl-C comes in between, none.

        The run also has, from one increment to the next, how far each node has slipped without a
        stop (`slip_since_stop`), and how uncertain each stick edge was between the nodes that it
        has passed (`passed_nodes`): both are brought up to the last state.

        Parameters
        ----------
        problem
            the contact problem, with friction coefficient f
        increments
            k that follow the last state of the run: each with the state at its end (`state`), the
            node states (open, stick or slip) that were solved for, and its number of iterations
        segment
            the curved segment of the load path that they are on; None on straight ones, where the
            loads enclose no area with their chords
        load_units
            (5,) what each load is divided by: P, Q, both bulk stresses, tilt or moment
        """
        if not increments:
            return
        states_with_start = [self.states[-1], *(increment.state for increment in increments)]

        # Energies and admissibility checks by name, (k,) each; friction work of the nodes, (k, n).
        energies_and_checks, nodal_work_of_increments = _energies_and_checks(
            problem,
            states_with_start,
            [increment.solved_states for increment in increments],
            _enclosed_areas(states_with_start, segment, load_units),
        )
        slips_since_stop = _slips_since_stop(states_with_start, self.slip_since_stop)

        # Instants (k + 1,) at which all of the contact sticks, by the shear at its edges. A problem
        # whose nodes are all at x >= 0 is one half of a contact that is its own mirror image.
        x = problem.interface.x
        sticks_in_full_at_states = shear_grows_within_cone(
            states_with_start, problem.friction, is_half=bool(-x[0] < x[-1] / 2)
        )

        # Edges of contact and stick are located between nodes by the load that moves them.
        passed_nodes = dict(self.passed_nodes)  # changed in place by `stick_by_load`
        contact_edges = contact_by_load(problem, states_with_start[1:])
        stick_edges = EdgesByLoad.nowhere(len(increments))
        if self.places_stick_edges:
            stick_edges = stick_by_load(problem, states_with_start, slips_since_stop, passed_nodes)

        # All attributes are set at once, so that Ctrl-C comes before or after it.
        vars(self).update(
            states=self.states + states_with_start[1:],
            increment_records=[*self.increment_records, energies_and_checks],
            iterations=self.iterations + [increment.iterations for increment in increments],
            nodal_work=self.nodal_work + nodal_work_of_increments.sum(axis=0),
            contact_edges=[*self.contact_edges, contact_edges],
            stick_edges=[*self.stick_edges, stick_edges],
            passed_nodes=passed_nodes,
            slip_since_stop=slips_since_stop[-1],
            sticks_in_full=[*self.sticks_in_full, sticks_in_full_at_states[1:]],
        )

    def end_stretches(self, last_states: list[int]) -> None:
        """End stretches (parts of the load path between turning points) at the states of these
        indices: on a long path, states of them or earlier ones lose pressure, shear and gap.
        """
        self.ends_of_stretches += last_states
        for last_state in last_states:
            if self.may_thin and last_state > self._first_of_stretch:
                self._thin(self._first_of_stretch, last_state)
            self._first_of_stretch = last_state

    def close_cycle(self, edge_excess: Excess) -> None:
        """End a revolution: correct its friction work for the mesh, and store it.

        On a mesh the edges of contact and stick jump from node to node. This adds the work
        `edge_excess.value`, which edges that pass between the nodes do not have. The friction work
        of all increments and nodes of the revolution, and Q dU of its increments, are multiplied by
        one factor.

        - `increment_records`: energies and checks by name, one dict for each batch of consecutive
          increments; "dissipation" (friction work) and "loop_work" (Q dU) are among them.
        - `nodal_work`: (n,) friction work of each node in the revolution.
        - `iterations`: an entry for each increment of the run.
        """
        nodal_work = self.nodal_work
        friction_work = float(nodal_work.sum())
        factor = 1 - edge_excess.value / friction_work if friction_work > 0 else 1.0

        # Batches of increments from the last one back to the start of the revolution.
        first_increment_of_cycle = self.cycle_starts[-1]
        first_increment_of_batch = len(self.iterations)
        for batch_number in reversed(range(len(self.increment_records))):
            energies_and_checks = self.increment_records[batch_number]
            first_increment_of_batch -= len(energies_and_checks["loop_work"])
            if first_increment_of_batch < first_increment_of_cycle:
                break
            corrected_works = {
                name: energies_and_checks[name] * factor for name in ("dissipation", "loop_work")
            }
            self.increment_records[batch_number] = energies_and_checks | corrected_works

        self.nodal_work_by_cycle.append(nodal_work * factor)
        self.edge_excess_by_cycle.append(edge_excess)

    def _thin(self, first_index: int, last_index: int) -> None:
        """Free memory on a long path at the end of a stretch, a part of it between turning points:
        some states of the stretch lose pressure, shear and gap of their nodes.

        These are the states from `first_index` up to `last_index`. The last one stays complete for
        now, as the next increment starts from it. Where more than 4000 states
        (`MOST_COMPLETE_STATES`) are complete, earlier ones lose theirs too.

        `_thinning` decides which states stay complete: every n-th one between ends of stretches,
        and every n-th end. Doubling n, a stride of either kind, leaves half as many.

        - `end_number_of_state`: numbers the states at ends of stretches, by their index.
        - `index_of_largest_load`: of the state with the largest P.
        - `n_stored`: how many states are complete.
        """
        thinning = self._thinning
        thinning.end_number_of_state[last_index] = len(thinning.end_number_of_state)
        for index in range(first_index, last_index):
            largest_load = self.states[thinning.index_of_largest_load].normal_load
            if self.states[index].normal_load > largest_load:
                thinning.index_of_largest_load = index
            if self._drop_forces_and_gap(index):
                continue

            # It stays complete. With too many such states, half as many stay so from here on.
            thinning.n_stored += 1
            while thinning.n_stored > MOST_COMPLETE_STATES and thinning.can_double_a_stride(
                len(self.states)
            ):
                thinning.double_a_stride()
                indices_so_far = [
                    int(stored_index)
                    for stored_index in self.stored_indices[:-1]
                    if stored_index <= index
                ]
                thinning.n_stored -= sum(map(self._drop_forces_and_gap, indices_so_far))

    def _drop_forces_and_gap(self, index: int) -> bool:
        """Take pressure, shear and gap off the state of this index, to free memory, unless the
        state is one that keeps them; return whether they were taken off.

        The first state keeps them, that of the largest P, and the starts of the last two
        revolutions. Of the states between ends of stretches, and of these ends, every n-th does
        (`_thinning`).
        """
        if index in (0, self._thinning.index_of_largest_load, *self.cycle_starts[-2:]):
            return False
        if self._thinning.keeps_state(index):
            return False
        state = self.states[index]
        # approach, U, tilt, and slip of the nodes; behind them stand pressure, shear and gap
        values_up_to_slip = state.values[: 3 + len(state.node_states)]
        self.states[index] = replace(state, values=read_only_copy(values_up_to_slip))
        return True


@dataclass(frozen=True)
class Pace:
    """Units of the loads of a path, and how finely it is stepped.

    Attributes
    ----------
    load_unit
        what P and Q are divided by
    steps_per_cycle
        regular increments of one revolution, or of the longest side of a polygon
    step_tolerance
        step error of a revolution over its dissipation that calls for shorter increments
    length_unit, stress_unit
        half-width a and E*; with `load_unit` the units of bulk stress, tilt and moment follow
    expected_dissipation
        friction work of a revolution, or of a path that does not repeat, over P^2/E*; 0 if
        unknown
    kinks_bound_error
        whether the step error is taken for the friction work that nodes add which start to slide
        within an increment, see `stepping.StepTolerance`
    """

    load_unit: float
    steps_per_cycle: int
    step_tolerance: float
    length_unit: float = 1.0
    stress_unit: float = 1.0
    expected_dissipation: float = 0.0
    kinks_bound_error: bool = False

    def load_units(self, problem: ContactProblem) -> tuple[float, ...]:
        """What each load is divided by, (5,): P, Q, both bulk stresses, tilt or moment. Where the
        movement of an actuator stands in the place of P or Q, the unit is that of the movement.

        They follow from three units: `load_unit` of P and Q, the half-width `length_unit`, and
        `stress_unit`, E*. `problem` states whether the moment is given, or the tilt, and whether
        actuators prescribe approach and tangential displacement in the place of P and Q.
        """
        bulk_stress_unit = self.load_unit / self.length_unit
        tilt_unit = bulk_stress_unit / self.stress_unit
        moment_unit = self.load_unit * self.length_unit
        tilt_or_moment_unit = moment_unit if problem.has_given_moment else tilt_unit
        movement_unit = self.load_unit / self.stress_unit
        actuators = problem.actuators
        normal_unit = movement_unit if actuators.prescribe_approach else self.load_unit
        tangential_unit = movement_unit if actuators.prescribe_displacement else self.load_unit
        return (
            normal_unit,
            tangential_unit,
            bulk_stress_unit,
            bulk_stress_unit,
            tilt_or_moment_unit,
        )


def run_path(
    problem: ContactProblem,
    path: LoadPath,
    pace: Pace,
    cycles: int,
    progress: Progress,
    *,
    uncertainty: Callable[[PathRun], float] = lambda _run: np.inf,
    keep_all_states: bool = False,
    places_stick_edges: bool = True,
) -> PathRun:
    """Solve a load path increment by increment: initial loading, then at most `cycles`
    revolutions, until one repeats the one before. Returns states and friction work; all scaled.

    A revolution repeats where its nodal forces do, and the friction work W is closer to its limit
    than W is uncertain. A ConvergenceError or Ctrl-C ends the run and becomes its `failure`;
    everything solved before it stays.

    Parameters
    ----------
    problem
        the contact problem, scaled
    path
        loads over time
    pace
        units of the loads, and how finely the path is stepped: `steps_per_cycle` increments
    cycles
        largest number of revolutions
    progress
        called with (number of parts of the path done, number of all, text) as the run proceeds
    uncertainty
        function from the run to the uncertainty of W by mesh and steps, scaled; NaN where it is
        unknown: then 5e-4 of W
    keep_all_states
        whether all states of a long path stay complete, instead of some losing pressure, shear and
        gap of their nodes to save memory
    places_stick_edges
        whether stick edges are located between nodes at each instant, which takes a
        quarter of the time of an increment; the friction work that edges add is found in any case

    Returns
    -------
    PathRun
        Its `nodal_work` (n,) is the friction work of each node in the part of the path that was
        solved last (initial loading or a revolution); its `steady_from` the number, from 0, of the
        revolution that repeats, None where none does.
    """
    # States of a long path may lose nodal values (`may_thin`) on straight segments alone: there the
    # straight lines between the complete states, on which theory is evaluated, are the path itself.
    has_straight_segments = all(
        is_straight(segment) for segment in (*path.initial_loading, *path.cycle)
    )
    run = PathRun(
        [_initial_state(problem, path, pace)],
        may_thin=has_straight_segments and not keep_all_states,
        places_stick_edges=places_stick_edges,
    )

    # The follower solves segments of the path and appends their increments to the run. The longest
    # segment of the initial loading has an eighth of the increments of a revolution's longest one.
    follower = _Follower(problem, run, pace, progress)
    try:
        follower.follow_segments(path.initial_loading, pace.steps_per_cycle / 8, "initial loading")
        if path.period is None:
            run.nodal_work_by_cycle.append(run.nodal_work)  # work of each node on the whole path
            return run
        for number in range(cycles):
            follower.follow_revolution(path.segments_of_cycle(number), number)
            if _repeats(run, uncertainty):
                run.steady_from = number
                break
    except ConvergenceError as failure:
        run.failure = failure
    except KeyboardInterrupt:
        run.failure = Interrupted(
            f"interrupted at time {run.states[-1].time:.6g}, after {len(run.iterations)} steps"
        )
    return run


def _repeats(run: PathRun, uncertainty: Callable[[PathRun], float]) -> bool:
    """Whether the last revolution ended as it started, to 5e-4 of the largest nodal force, and its
    friction work differs from the limit of all revolutions by no more than its uncertainty.

    Parameters
    ----------
    run
        `force_change_by_cycle` is the change of nodal forces over each revolution, over the largest
        force; `nodal_work` (n,) the friction work of each node in the last one; `trend` how the
        work of the revolutions goes on, with the change to its limit
    uncertainty
        function from the run to the uncertainty of its friction work; where it is NaN, 5e-4 of the
        work takes its place
    """
    # LARGEST_CHANGE_OF_REPEAT: 5e-4
    if run.force_change_by_cycle[-1] > LARGEST_CHANGE_OF_REPEAT:
        return False
    allowed_error = uncertainty(run)
    if np.isnan(allowed_error):
        allowed_error = LARGEST_CHANGE_OF_REPEAT * float(run.nodal_work.sum())
    return abs(run.trend.change_to_limit) <= allowed_error


def _initial_state(problem: ContactProblem, path: LoadPath, pace: Pace) -> InterfaceState:
    """State of the contact at the start of a path, where it carries no load.

    Where the moment M is given, the line of action of P is at x = M/P of an instant soon after the
    start, since M = P = 0 at the start; at x = 0 where P is not positive there. That instant is
    after a thousandth of the first segment of the path. `pace` has the units of the loads.
    """
    segment = path.initial_loading[0]
    load_units = pace.load_units(problem)  # (5,) of P, Q, both bulk stresses, tilt or moment
    time_soon_after = segment.start + _SHARE_OF_FIRST_SEGMENT * (segment.end - segment.start)
    normal_load, *_, moment = scaled_loads(segment, time_soon_after, load_units)
    x_of_load = moment / normal_load if problem.has_given_moment and normal_load > 0 else 0.0
    return problem.unloaded_state(
        path.start, scaled_loads(segment, path.start, load_units), x_of_load
    )


@dataclass(eq=False)
class _Follower:
    """Solves the segments of a path one after the other, and adds their increments to a run.

    Attributes
    ----------
    problem
        the contact problem, scaled
    run
        states, energies and checks of the path so far
    pace
        units of the loads, and how finely the path is stepped
    progress
        called with (done, total, text) at the start of each part between turning points
    """

    problem: ContactProblem
    run: PathRun
    pace: Pace
    progress: Progress

    def follow_revolution(self, segments: tuple[LoadSegment, ...], number: int) -> None:
        """Solve one revolution of the load path, correct its friction work for the mesh, and
        compare the nodal forces at its end with those at its start.

        `segments` are those of the path in this revolution, `number` counts revolutions from 0. The
        run (`self.run`) receives the states, the index at which the revolution starts, and the
        change of its forces.
        """
        start_state = self.run.states[-1]
        # its index: each increment, of which `iterations` has an entry, leads to one more state
        self.run.cycle_starts.append(len(self.run.iterations))
        self.follow_segments(segments, self.pace.steps_per_cycle, f"revolution {number + 1}")

        # `excess`: friction work that edges add which move from node to node
        states_of_cycle = self.run.states[self.run.cycle_starts[-1] :]
        self.run.close_cycle(excess(self.problem, states_of_cycle))

        change_of_forces = _relative_change_of_forces(
            start_state, self.run.states[-1], self.problem.friction
        )
        self.run.force_change_by_cycle.append(change_of_forces)

    def follow_segments(
        self, segments: tuple[LoadSegment, ...], n_increments_of_longest: float, title: str
    ) -> None:
        """Solve the increments along consecutive segments of the load path and append them to the
        run. What was solved before an error or Ctrl-C is appended too.

        Parameters
        ----------
        segments
            segments of the load path, each between two vertices or a whole curve
        n_increments_of_longest
            regular increments of the longest segment; shorter ones have fewer
        title
            of this part of the path, for reports of progress
        """
        # Stretches: parts of the path between turning points of its loads.
        stretches_of_segments = self._stretches(segments, n_increments_of_longest)
        n_stretches = len(stretches_of_segments)
        load_units = self.pace.load_units(self.problem)  # (5,) what each load is divided by
        self.run.nodal_work = np.zeros_like(self.problem.initial_gap)  # friction work of each node
        # step error over duration with which an increment is accepted
        tolerance = self._step_tolerance(duration=segments[-1].end - segments[0].start)

        # The batch appends increments to the run some 32 at a time, as their energies are then
        # computed together.
        batch = _Batch(self.problem, self.run, load_units)
        try:
            for number, stretch in enumerate(stretches_of_segments):
                self._report_progress(number, n_stretches, title)
                batch.start_stretch(stretch)
                try:
                    for increment in increments_along(
                        self.problem, batch.last_state, stretch, load_units, tolerance
                    ):
                        batch.add(increment)
                finally:
                    batch.end_stretch()
        finally:
            batch.move_to_run()
        self._report_progress(n_stretches, n_stretches, title)

    def _step_tolerance(self, duration: float) -> StepTolerance:
        """Tolerance of the step error of an increment: its largest value per unit of time, and
        whether kinks bound the error. The former is a share of the friction work of a revolution,
        over the `duration` of the part of the path that is to be solved; scaled.
        """
        reference_work = _reference_dissipation(self.run, self.pace, self.problem.friction)
        return StepTolerance(
            self.pace.step_tolerance * reference_work / duration, self.pace.kinks_bound_error
        )

    def _stretches(
        self, segments: tuple[LoadSegment, ...], n_increments_of_longest: float
    ) -> list[Stretch]:
        """Cut segments of the load path at their turning points, each part with the instants at
        which its regular increments end. Shorter segments have fewer increments, in proportion to
        their duration; the longest has `n_increments_of_longest`.
        """
        # Turning points are those of P and Q +- f P. Where an actuator prescribes the tangential
        # displacement U, U turns round in the place of the latter.
        is_displacement_given = self.problem.actuators.prescribe_displacement
        friction = 0.0 if is_displacement_given else self.problem.friction
        longest_duration = max(segment.end - segment.start for segment in segments)
        stretches_of_segments: list[Stretch] = []
        for segment in segments:
            relative_duration = (segment.end - segment.start) / longest_duration
            n_increments = n_increments_of_longest * relative_duration
            stretches_of_segments += stretches(segment, friction, n_increments)
        return stretches_of_segments

    def _report_progress(self, n_done: int, n_stretches: int, title: str) -> None:
        """Report to `self.progress` how many parts of the load path are done (`n_done` of
        `n_stretches`), and how many steps and contact iterations so far.
        """
        n_steps = len(self.run.iterations)
        iterations = self.problem.work_counts["contact iterations"]
        text = f"{title}, {n_steps} steps, {iterations} contact iterations"
        self.progress(n_done, n_stretches, text)


@dataclass(eq=False)
class _Batch:
    """Increments that are solved and not in the run yet: the energies of up to
    `_INCREMENTS_PER_BATCH` of them are computed together. They are of one curved segment of the
    load path, or of straight segments, whose loads enclose no area with their chords.

    Attributes
    ----------
    problem, run
        the contact problem, and the run that they are appended to
    load_units
        (5,) what each load is divided by
    curved_segment
        the curved segment that they are of; None on straight ones
    increments
        not in the run yet
    ends_of_stretches
        indices of the states at which stretches have ended since the last batch
    """

    problem: ContactProblem
    run: PathRun
    load_units: tuple[float, ...]
    curved_segment: LoadSegment | None = None
    increments: list[Increment] = field(default_factory=list)
    ends_of_stretches: list[int] = field(default_factory=list)

    @property
    def last_state(self) -> InterfaceState:
        """State at the end of the last increment, from which the next one starts."""
        return self.increments[-1].state if self.increments else self.run.states[-1]

    def start_stretch(self, stretch: Stretch) -> None:
        """Begin a part of the load path between turning points. Increments of another segment are
        moved into the run first, if that or this one is curved.
        """
        curved_segment = None if is_straight(stretch.segment) else stretch.segment
        if curved_segment is not self.curved_segment:
            self.move_to_run()
            self.curved_segment = curved_segment

    def add(self, increment: Increment) -> None:
        """Add a solved increment to the batch; a full one, of 32, is moved into the run."""
        self.increments.append(increment)
        if len(self.increments) == _INCREMENTS_PER_BATCH:
            self.move_to_run()

    def end_stretch(self) -> None:
        """End a stretch (part of the load path between turning points) at the last state: its index
        is stored.
        """
        self.ends_of_stretches.append(len(self.run.states) - 1 + len(self.increments))

    def move_to_run(self) -> None:
        """Append the increments of the batch, and the indices of states at which stretches of the
        load path ended, to the run; and empty the batch.
        """
        increments = self.increments
        ends_of_stretches = self.ends_of_stretches
        # Emptied first: an error or Ctrl-C within `append` must not have them appended twice.
        self.increments = []
        self.ends_of_stretches = []
        self.run.append(self.problem, increments, self.curved_segment, self.load_units)
        self.run.end_stretches(ends_of_stretches)


def _reference_dissipation(run: PathRun, pace: Pace, friction: float) -> float:
    """Reference for the tolerated step error, which is a share of it, over P^2/E*: the friction
    work of the revolution before, or else the one expected, but at least 3e-3 f^2 P^2/E*.

    It is rounded down to f^2 times a power of two. So the little that the initial loading changed
    in the revolution before does not change the increments. And loads with Q in proportion to f
    have the same increments at any f.

    Parameters
    ----------
    run
        its `nodal_work_by_cycle` is (n,) the friction work of each node, for each revolution
    pace
        its `expected_dissipation` is the expected work of a revolution, 0 if unknown
    friction
        coefficient f
    """
    friction_squared = max(friction**2, 1e-300)  # without friction there is no step error
    expected_work = (
        float(run.nodal_work_by_cycle[-1].sum())
        if run.nodal_work_by_cycle
        else pace.expected_dissipation
    )
    work_over_friction_squared = 2.0 ** np.floor(
        np.log2(max(expected_work / friction_squared, 1e-300))
    )
    # _LEAST_DISSIPATION: 3e-3
    return float(max(work_over_friction_squared, _LEAST_DISSIPATION) * friction_squared)


def _relative_change_of_forces(
    state_before: InterfaceState, state_after: InterfaceState, friction: float
) -> float:
    """Largest change of a nodal force between two states, over the largest nodal p of the later
    one. The force is p, or q over f (over 1 if f > 1), since with little friction all of q is
    small.

    # notation: p pressure and q shear of the nodes, f coefficient of friction
    """
    change_of_pressure = np.abs(state_after.pressure - state_before.pressure).max()
    change_of_shear = np.abs(state_after.shear - state_before.shear).max()
    largest_change = change_of_pressure
    if change_of_shear > 0:
        largest_change = max(largest_change, change_of_shear / min(friction, 1.0))
    return float(largest_change / np.max(state_after.pressure))
