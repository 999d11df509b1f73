"""States of the nodes as a reader sees them: what only creeps, by the error of the mesh or by
round-off, sticks.

A run has m + 1 contact states (`InterfaceState`), one before the first increment and one after
each of m. In each of them a node is open, sticks or slips: its node state.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.law import slip_sign
from scenes import STICK
from scenes.array_types import Array, Mask, States

# A sliding node that has come less far, since it last stuck or turned round, than this share of the
# farthest one of its sense counts as sticking: at the turning points of the load whole regions come
# back to the cone at once, and creep there by the mesh's error. Slip grows as the distance from the
# stick edge to the power 3/2, so the share costs half a hundredth of the slip zone.
_LEAST_TRAVEL_SHARE = 3e-4
# The same of a node that the load does not drive, and that slips less than this share of the
# largest slip per change of load in the revolution. What the mesh makes is 1e-5 to 4e-4 of that,
# without the cure of N - T up to 9e-3.
_LEAST_SPEED_SHARE = 1e-2
# Increments that are looked at together.
_INCREMENTS_PER_BLOCK = 512
# Slip of an increment, over the largest of all, below which it is rounding.
_ROUNDING = 1e-9
# Nodes inside each edge of contact whose shear shows whether the contact sticks in full: the mesh
# spoils the outermost ones, and the ratio of q and p is smooth farther in. Share of f up to which
# the ratio of their changes counts as less than f.
_NODES_AT_EDGE = slice(2, 6)
_LESS_THAN_F = 0.9


def reported_states(
    problem: ContactProblem, contact_states: Sequence[InterfaceState], cycle_starts: Sequence[int]
) -> States:
    """Node states as they are reported to the user, open, stick or slip, (m + 1, n): a node that
    slides so little that it may be round-off or error of the mesh sticks.

    Slip by the error of the mesh can be told only between like bodies, where half-plane theory
    holds. Between others pressing alone makes nodes slip, and slowly so near the stick edge: there
    only round-off is removed.

    Parameters
    ----------
    problem
        the contact problem; the bodies are alike if pressure causes no slip in it
        (`interface.coupling` is None)
    contact_states
        the m + 1 contact states of the load path
    cycle_starts
        index of the contact state at which each revolution starts; what comes before them is the
        initial loading
    """
    if problem.interface.coupling is not None:
        return law_states(contact_states)  # without slip that may be round-off
    # Without slip by the error of the mesh, too. `friction`: coefficient f; the last argument: gap
    # and slip of the nodes by unit bulk stresses of both bodies and by the tilt, None without any.
    return visible_states(
        contact_states,
        cycle_starts,
        problem.friction,
        problem.interface.gap_and_slip_per_stress_and_tilt,
    )


def law_states(contact_states: Sequence[InterfaceState]) -> States:
    """Node states by the law of friction, open, stick or slip, (m + 1, n). A node on the Coulomb
    limit that moves by no more than round-off in an increment sticks after it.

    Round-off is a slip of up to 1e-9 of the largest slip of any node in any increment.
    `contact_states` are the m + 1 of the load path; up to the first, nothing has moved.
    """
    node_states = np.stack([state.node_states for state in contact_states])
    # ranges of some hundred increments, (k,) each, to save memory
    blocks = _blocks_of_increments(len(contact_states) - 1)
    largest_slip = max(
        (float(np.abs(_slip_of_increments(contact_states, block)).max()) for block in blocks),
        default=0.0,
    )
    has_moved = np.zeros(node_states.shape, dtype=bool)
    for block in blocks:
        ends_of_block = slice(block.start + 1, block.stop + 1)  # contact states after increments
        slip_along_sense = slip_sign(node_states[ends_of_block]) * _slip_of_increments(
            contact_states, block
        )
        # _ROUNDING: 1e-9
        has_moved[ends_of_block] = slip_along_sense > _ROUNDING * largest_slip
    node_states[(slip_sign(node_states) != 0) & ~has_moved] = STICK
    return node_states


def _blocks_of_increments(n_increments: int) -> list[slice]:
    """Ranges of 512 increments each, as slices: arrays of all increments of a long record would
    take gigabytes.
    """
    return [
        slice(first_increment, min(first_increment + _INCREMENTS_PER_BLOCK, n_increments))
        for first_increment in range(0, n_increments, _INCREMENTS_PER_BLOCK)
    ]


def _slip_of_increments(contact_states: Sequence[InterfaceState], block: slice) -> Array:
    """Slip of the nodes in each of k increments, (k, n): difference of neighbouring contact states.
    `block` are the numbers of these increments. In the values of a state the slip of the n nodes
    stands behind approach, tangential displacement and tilt.
    """
    n_nodes = len(contact_states[0].node_states)
    slip_of_states = [
        state.values[3 : 3 + n_nodes] for state in contact_states[block.start : block.stop + 1]
    ]
    return np.diff(slip_of_states, axis=0)


def visible_states(
    contact_states: Sequence[InterfaceState],
    cycle_starts: Sequence[int],
    friction: float,
    gap_and_slip_per_stress_and_tilt: Array | None = None,
) -> States:
    """Node states as they are reported between like bodies, open, stick or slip, (m + 1, n): those
    of the law of friction, but a node that hardly moves (creeps) sticks.

    A sliding node counts as slipping if two conditions are met. It has slid far enough since it
    last stopped or turned round: 3e-4 of the distance of the farthest node in its direction. And
    the load drives its slip, or it is fast: its slip per change of load is above a hundredth of the
    largest. The load drives forward slip where dQ > f dP and reverse slip where -dQ > f dP.

    Parameters
    ----------
    contact_states
        the m + 1 contact states of the load path
    cycle_starts
        index of the contact state at which each revolution starts; what comes before them is the
        initial loading
    friction
        coefficient f
    gap_and_slip_per_stress_and_tilt
        (2, n, 3) gap and slip of the nodes by a unit of the bulk stresses of lower and upper body
        and of the tilt; None without any
    """
    node_states = np.stack([state.node_states for state in contact_states])
    load_increments = np.diff([state.loads for state in contact_states], axis=0)  # (m, n_loads)
    # `least_fast_slip` (m,): beyond it a node counts as fast
    largest_slip, least_fast_slip = _slip_limits(
        contact_states, node_states, load_increments, cycle_starts
    )
    travel_before = np.zeros(len(contact_states[0].node_states))
    for block in _blocks_of_increments(len(load_increments)):
        states_in_block = node_states[block.start + 1 : block.stop + 1]  # a view: written below
        sense = slip_sign(states_in_block).astype(float)

        # Slip of each increment, and distance since a node last stopped or turned round, (k, n).
        slip = _slip_of_increments(contact_states, block)
        # _ROUNDING: 1e-9
        slip[np.abs(slip) <= _ROUNDING * largest_slip] = 0.0
        travels = slip_since_stop(slip, travel_before)
        travel_before = travels[-1]

        is_driven = _is_driven(
            contact_states[block.start : block.stop + 1],
            load_increments[block],
            states_in_block,
            friction,
            gap_and_slip_per_stress_and_tilt,
        )
        is_fast = np.abs(slip) > least_fast_slip[block, None]

        # Nodes that only creep stick.
        states_in_block[(sense != 0) & ~((is_driven | is_fast) & _is_far(sense, travels))] = STICK
    first_states = node_states[:1]
    first_states[slip_sign(first_states) != 0] = STICK  # nothing has moved yet
    return node_states


def _is_driven(
    contact_states: Sequence[InterfaceState],
    load_increments: Array,
    node_states: States,
    friction: float,
    gap_and_slip_per_stress_and_tilt: Array | None,
) -> Mask:
    """Whether the load drives the slip of each node in k increments, (k, n): forward slip where
    dQ > f dP, reverse slip where -dQ > f dP. Bulk stress and tilt change dP and dQ from node to
    node.

    In full stick the pressure changes by [dP/pi - d(tilt) (x - x_m)/A] over the root of
    a^2 - (x - x_m)^2, and the shear likewise by dQ and a strain: the roots cancel.

    # notation: x_m middle of the stick zone, a half-width, A = 2/E* = 2 in scaled variables

    Parameters
    ----------
    contact_states
        the k + 1 contact states around the increments
    load_increments
        (k, n_loads) changes of the loads
    node_states
        (k, n) open, stick or slip of the nodes after the increments
    friction
        coefficient f
    gap_and_slip_per_stress_and_tilt
        (2, n, 3) gap and slip of the nodes by a unit of the bulk stresses of lower and upper body
        and of the tilt; None without any
    """
    rise_of_p = load_increments[:, 0, None]
    rise_of_q = load_increments[:, 1, None]
    if gap_and_slip_per_stress_and_tilt is not None:
        stresses_and_tilt = [state.stresses_and_tilt for state in contact_states]
        gap_from_middle, slip_from_middle = _gap_and_slip_from_middle(
            np.diff(stresses_and_tilt, axis=0),
            gap_and_slip_per_stress_and_tilt,
            node_states == STICK,
        )
        rise_of_p = rise_of_p - np.pi / 2 * gap_from_middle
        rise_of_q = rise_of_q + np.pi / 2 * slip_from_middle
    return np.asarray(slip_sign(node_states).astype(float) * rise_of_q > friction * rise_of_p)


def _is_far(slip_sense: Array, travels: Array) -> Mask:
    """Whether each sliding node has slid far enough since it last stopped or turned round, (k, n):
    more than 3e-4 of the distance of the farthest node that slides in its direction.

    `slip_sense` (k, n) is 1 forward, -1 in reverse, 0 without slip after each of k increments;
    `travels` (k, n) is the distance, with the sign of the slip. False where a node does not slide.
    """
    is_far = np.zeros(travels.shape, dtype=bool)
    for direction in (1, -1):
        distance = np.where(slip_sense == direction, direction * travels, 0.0)
        # _LEAST_TRAVEL_SHARE: 3e-4
        farthest_distance = distance.max(axis=1, keepdims=True)
        is_far |= (slip_sense == direction) & (distance > _LEAST_TRAVEL_SHARE * farthest_distance)
    return is_far


def _slip_limits(
    contact_states: Sequence[InterfaceState],
    node_states: States,
    load_increments: Array,
    cycle_starts: Sequence[int],
) -> tuple[float, Array]:
    """Largest |slip| of any node in any of m increments, and for each increment, (m,), the |slip|
    beyond which a node counts as fast; both over P/E*.

    Fast is more than a hundredth of the largest slip per change of load in the same revolution,
    times the change of load of the increment. Change of load is the sum of |dP|, |dQ| and the
    others.

    Parameters
    ----------
    contact_states
        the m + 1 contact states of the load path
    node_states
        (m + 1, n) open, stick or slip of their nodes
    load_increments
        (m, n_loads) changes of the loads
    cycle_starts
        index of the contact state at which each revolution starts
    """
    # Largest slip of the sliding nodes in each increment, over its change of load.
    n_increments = len(load_increments)
    # The least number keeps an increment without any change of load from a division by zero.
    load_changes = np.maximum(np.abs(load_increments).sum(axis=1), 1e-300)
    largest_sliding_slip = np.zeros(n_increments)  # of the nodes that slide, in each increment
    largest_slip = 0.0  # of all nodes
    for block in _blocks_of_increments(n_increments):
        sense = slip_sign(node_states[block.start + 1 : block.stop + 1]).astype(float)
        slip = _slip_of_increments(contact_states, block)
        largest_sliding_slip[block] = np.abs(slip * sense).max(axis=1)
        largest_slip = max(largest_slip, float(np.abs(slip).max()))

    largest_slip_per_load = _largest_in_revolution(
        largest_sliding_slip / load_changes, cycle_starts
    )
    # _LEAST_SPEED_SHARE: 1e-2
    least_fast_slip = _LEAST_SPEED_SHARE * largest_slip_per_load * load_changes
    return largest_slip, least_fast_slip


def _largest_in_revolution(values: Array, cycle_starts: Sequence[int]) -> Array:
    """For each of m increments, (m,), the largest of the non-negative `values` (m,) in its
    revolution. The initial loading, before the first revolution, counts as one.

    `cycle_starts` are the numbers of the increments with which revolutions start.

    >>> _largest_in_revolution(np.array([5.0, 1.0, 3.0, 2.0]), [1]).tolist()
    [5.0, 3.0, 3.0, 3.0]
    """
    starts = np.asarray(cycle_starts, dtype=int)
    revolution_of_increment = np.searchsorted(starts, np.arange(len(values)), side="right")
    largest_of_revolution = np.array(
        [
            values[revolution_of_increment == number].max(initial=0.0)
            for number in range(len(cycle_starts) + 1)
        ]
    )
    return largest_of_revolution[revolution_of_increment]


def slip_since_stop(slip: Array, travel_before: Array | float) -> Array:
    """Distance (k, n) that each node has slipped in its present direction, after each of k
    increments; with the sign of the slip. It starts again where a node stops or turns round.

    `slip` (k, n) is that of the increments, `travel_before` (n,) the distance before the first.

    >>> slip_since_stop(np.array([[1.0], [2.0], [-1.0], [0.0]]), 0.5).T.tolist()
    [[1.5, 3.5, -1.0, 0.0]]
    """
    travels = slip.copy()
    travel = np.asarray(travel_before)
    for increment in range(len(travels)):
        travels[increment] += np.where(travel * travels[increment] > 0, travel, 0.0)
        travel = travels[increment]
    return travels


def shear_grows_within_cone(
    contact_states: Sequence[InterfaceState], friction: float, *, is_half: bool
) -> Mask:
    """Instants at which bodies of like materials stick in full by the shear at the edges of
    contact, whatever the history, (m + 1,).

    Since the instant before, the shear of nodes at both edges of contact has changed by less than f
    times what their pressure has grown by. At the first instant it is not known: False.

    The loads alone do not decide it for bodies of finite size: P alone shears two shapes, and their
    size bends the ratio of shear and pressure. Nor do they where bulk stress or tilt changes.

    The shear is that of four nodes inside each edge, behind the two outermost ones, which the mesh
    distorts; "less than f times" is up to 0.9 f.

    Parameters
    ----------
    contact_states
        the m + 1 contact states of the load path, in order of time, with pressure and shear
    friction
        f
    is_half
        whether the states are on the nodes at x >= 0 of a contact that is its own mirror image:
        then one edge is enough
    """
    sticks_in_full = np.zeros(len(contact_states), dtype=bool)
    for instant, (state_before, state_after) in enumerate(
        itertools.pairwise(contact_states), start=1
    ):
        closed_nodes = np.flatnonzero(state_before.is_closed & state_after.is_closed)
        n_closed_nodes = len(closed_nodes)
        if is_half:
            n_closed_nodes = 2 * n_closed_nodes - int(0 in closed_nodes)  # node 0 has no image
        # _NODES_AT_EDGE: positions 2 to 5 from the edge inwards
        if n_closed_nodes < 2 * _NODES_AT_EDGE.stop:
            continue
        nodes_at_edges = closed_nodes[::-1][_NODES_AT_EDGE]
        if not is_half:
            nodes_at_edges = np.append(closed_nodes[_NODES_AT_EDGE], nodes_at_edges)
        rise_of_pressure = (state_after.pressure - state_before.pressure)[nodes_at_edges]
        change_of_shear = np.abs(state_after.shear - state_before.shear)[nodes_at_edges]
        # _LESS_THAN_F: 0.9
        is_below_limit = change_of_shear < _LESS_THAN_F * friction * rise_of_pressure
        sticks_in_full[instant] = is_below_limit.all()
    return sticks_in_full


def _gap_and_slip_from_middle(
    stress_and_tilt_changes: Array, displacement_per_unit: Array, is_stuck: Mask
) -> tuple[Array, Array]:
    """Changes of gap and of slip of n nodes by bulk stress and tilt in k increments, (k, n) each,
    minus their values at the middle of the stick zone; 0 where nothing sticks.

    Parameters
    ----------
    stress_and_tilt_changes
        (k, 3) changes of the bulk stresses of lower and upper body and of the tilt
    displacement_per_unit
        (2, n, 3) gap and slip of the nodes by a unit of each
    is_stuck
        (k, n) whether a node sticks after an increment
    """
    # First and last node of the stick zone; its middle has the mean value of both.
    first_stick_node = np.argmax(is_stuck, axis=1)
    last_stick_node = is_stuck.shape[1] - 1 - np.argmax(is_stuck[:, ::-1], axis=1)
    end_nodes = np.stack([first_stick_node, last_stick_node], axis=1)
    has_stick_zone = is_stuck.any(axis=1, keepdims=True)

    def change_from_middle(value_per_unit: Array) -> Array:
        """Change of gap or slip of n nodes in k increments, (k, n), minus its value at the middle
        of the stick zone. `value_per_unit` (n, 3) is gap or slip by a unit of both bulk stresses
        and of tilt.
        """
        change = stress_and_tilt_changes @ value_per_unit.T
        middle_value = np.take_along_axis(change, end_nodes, axis=1).mean(axis=1, keepdims=True)
        return np.asarray((change - middle_value) * has_stick_zone)

    gap_per_unit, slip_per_unit = displacement_per_unit
    return change_from_middle(gap_per_unit), change_from_middle(slip_per_unit)
