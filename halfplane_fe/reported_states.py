"""States of the nodes as a reader sees them: what only creeps, by the error of the mesh or by
round-off, sticks.
"""

from __future__ import annotations

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


def reported_states(
    problem: ContactProblem, states: Sequence[InterfaceState], cycle_starts: Sequence[int]
) -> States:
    """States open, stick or slip of the contact nodes as they are reported to the user,
    (n_steps, n): a node that only creeps, by round-off or by the error of the mesh, sticks.

    Creep by the mesh can be told from slip only between bodies of one shape and material, where
    half-plane theory holds. Between others pressing alone makes nodes slip, and slowly so near the
    stick edge: there only round-off is removed.

    Parameters
    ----------
    problem
        the contact problem, whose compliance shows whether pressure and slip are coupled
    states
        contact states after all increments of the path
    cycle_starts
        index of the state at which each revolution starts; what comes before them is the
        initial loading
    """
    if problem.interface.coupling is not None:
        return law_states(states)
    return visible_states(states, cycle_starts, problem.friction, problem.interface.imposed)


def law_states(states: Sequence[InterfaceState]) -> States:
    """States open, stick or slip of the nodes by the law of friction, (n_steps, n), but for
    round-off: a node on the Coulomb limit that has not moved in an increment sticks.

    `states` are those after all increments of the path; at the first nothing has moved.
    """
    node_states = np.stack([state.state for state in states])
    blocks = _blocks(len(states) - 1)
    largest_slip = max(
        (float(np.abs(_slip_increments(states, steps)).max()) for steps in blocks), default=0.0
    )
    has_moved = np.zeros(node_states.shape, dtype=bool)
    for steps in blocks:
        slip = _slip_increments(states, steps)
        later_steps = slice(steps.start + 1, steps.stop + 1)
        has_moved[later_steps] = (
            slip_sign(node_states[later_steps]) * slip > _ROUNDING * largest_slip
        )
    node_states[(slip_sign(node_states) != 0) & ~has_moved] = STICK
    return node_states


def _blocks(n_increments: int) -> list[slice]:
    """Ranges of some hundred increments each: arrays of all increments of a long record would take
    gigabytes.
    """
    return [
        slice(first_step, min(first_step + _INCREMENTS_PER_BLOCK, n_increments))
        for first_step in range(0, n_increments, _INCREMENTS_PER_BLOCK)
    ]


def _slip_increments(states: Sequence[InterfaceState], steps: slice) -> Array:
    """(k, n) slip of the nodes in each of k increments, the difference of neighbouring states."""
    n_nodes = len(states[0].state)
    slip_of_states = [
        state.values[3 : 3 + n_nodes] for state in states[steps.start : steps.stop + 1]
    ]
    return np.diff(slip_of_states, axis=0)


def visible_states(
    states: Sequence[InterfaceState],
    cycle_starts: Sequence[int],
    friction: float,
    imposed: Array | None = None,
) -> States:
    """States open, stick or slip of the nodes as they are reported between like bodies,
    (n_steps, n): those of the law of friction, but a node that only creeps sticks.

    A sliding node slips if it has moved far enough since it last stopped or turned round, compared
    with the farthest one of its direction, and if the load drives it there or it is fast. The load
    drives forward slip where dQ > f dP and reverse slip where -dQ > f dP.

    Parameters
    ----------
    states
        contact states after all increments of the path
    cycle_starts
        index of the state at which each revolution starts; what comes before them is the
        initial loading
    friction
        coefficient f
    imposed
        (2, n, 3) gap and slip by a unit of the bulk stresses and of the tilt; None without any
    """
    node_states = np.stack([state.state for state in states])
    load_increments = np.diff([state.loads for state in states], axis=0)
    largest_slip, least_slip = _slip_limits(states, node_states, load_increments, cycle_starts)
    travel = np.zeros(len(states[0].state))
    for steps in _blocks(len(load_increments)):
        states_in_block = node_states[steps.start + 1 : steps.stop + 1]  # a view
        sense = slip_sign(states_in_block).astype(float)
        slip = _slip_increments(states, steps)
        slip[np.abs(slip) <= _ROUNDING * largest_slip] = 0.0
        travels = slip_since_stop(slip, travel)
        travel = travels[-1]
        rise_of_p = load_increments[steps, 0, None]
        rise_of_q = load_increments[steps, 1, None]
        if imposed is not None:
            # In full stick both tractions are [d(P, Q)/pi - d(tilt, strain) (x - m)/A] over one
            # root, m the middle of the stick zone, A = 2 in scaled variables.
            imposed_of_states = [state.imposed for state in states[steps.start : steps.stop + 1]]
            gap_by_imposed, slip_by_imposed = _about_stick_zone(
                np.diff(imposed_of_states, axis=0), imposed, states_in_block == STICK
            )
            rise_of_p = rise_of_p - np.pi / 2 * gap_by_imposed
            rise_of_q = rise_of_q + np.pi / 2 * slip_by_imposed
        is_driven = sense * rise_of_q > friction * rise_of_p
        may_slip = is_driven | (np.abs(slip) > least_slip[steps, None])
        for direction in (1, -1):
            slides = sense == direction
            distance = np.where(slides, direction * travels, 0.0)
            is_far = distance > _LEAST_TRAVEL_SHARE * distance.max(axis=1, keepdims=True)
            states_in_block[slides & ~(may_slip & is_far)] = STICK
    first_states = node_states[:1]
    first_states[slip_sign(first_states) != 0] = STICK  # nothing has moved yet
    return node_states


def _slip_limits(
    states: Sequence[InterfaceState],
    node_states: States,
    load_increments: Array,
    cycle_starts: Sequence[int],
) -> tuple[float, Array]:
    """Largest slip of any node in any increment, and for each of n increments the slip from which
    on a node that the load does not drive counts as fast, (n,).

    That is a hundredth of the fastest slip per change of load in its revolution, times the change
    of load of the increment.

    Parameters
    ----------
    states, node_states
        contact states after all increments, and open, stick or slip of their nodes
    load_increments
        (n, n_loads) changes of the loads
    cycle_starts
        index of the state at which each revolution starts
    """
    n_increments = len(load_increments)
    load_changes = np.maximum(np.abs(load_increments).sum(axis=1), 1e-300)
    largest_sliding = np.zeros(n_increments)  # slip of the nodes that slide, in each increment
    largest_slip = 0.0  # of all nodes
    for steps in _blocks(n_increments):
        sense = slip_sign(node_states[steps.start + 1 : steps.stop + 1]).astype(float)
        slip = _slip_increments(states, steps)
        largest_sliding[steps] = np.abs(slip * sense).max(axis=1)
        largest_slip = max(largest_slip, float(np.abs(slip).max()))
    starts = np.asarray(cycle_starts, dtype=int)
    revolution = np.searchsorted(starts, np.arange(n_increments), side="right")
    speed = largest_sliding / load_changes
    fastest = np.array(
        [speed[revolution == number].max(initial=0.0) for number in range(len(cycle_starts) + 1)]
    )
    return largest_slip, _LEAST_SPEED_SHARE * fastest[revolution] * load_changes


def slip_since_stop(slip: Array, travel_before: Array | float) -> Array:
    """Distance (k, n) that each node has slipped in one direction without a stop, with a sign, open
    or closed, after each of k increments.

    `slip` (k, n) is that of the increments, `travel_before` (n,) the distance before the first.
    """
    travels = slip.copy()
    travel = np.asarray(travel_before)
    for step in range(len(travels)):
        travels[step] += np.where(travel * travels[step] > 0, travel, 0.0)
        travel = travels[step]
    return travels


def _about_stick_zone(rise: Array, imposed: Array, sticks: Mask) -> tuple[Array, Array]:
    """Gap and slip of the nodes by changes of bulk stress and tilt, (k, n) each, minus their values
    at the middle of the stick zone; 0 where nothing sticks.

    Parameters
    ----------
    rise
        (k, 3) changes of both bulk stresses and of the tilt in k increments
    imposed
        (2, n, 3) gap and slip by a unit of each
    sticks
        (k, n) nodes that stick
    """
    last_sticking = sticks.shape[1] - 1 - np.argmax(sticks[:, ::-1], axis=1)
    end_nodes = np.stack([np.argmax(sticks, axis=1), last_sticking], axis=1)
    has_sticking_nodes = sticks.any(axis=1, keepdims=True)
    differences = []
    for by_unit in imposed:
        values = rise @ by_unit.T
        value_at_middle = np.take_along_axis(values, end_nodes, axis=1).mean(axis=1, keepdims=True)
        differences.append((values - value_at_middle) * has_sticking_nodes)
    gap_by_rise, slip_by_rise = differences
    return gap_by_rise, slip_by_rise
