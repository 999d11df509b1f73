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
_MOVED = 3e-4
# The same of a node that the load does not drive, and that slips less than this share of the
# largest slip per change of load in the revolution. What the mesh makes is 1e-5 to 4e-4 of that,
# without the cure of N - T up to 9e-3.
_CREEP = 1e-2
# Increments that are looked at together.
_AT_ONCE = 512
# Slip of an increment, over the largest of all, below which it is rounding.
_ROUNDING = 1e-9


def reported_states(
    problem: ContactProblem, states: Sequence[InterfaceState], cycle_starts: Sequence[int]
) -> States:
    """States of the nodes as the user sees them, (n_steps, n): between coupled bodies those of the
    law; of others a node that only creeps by the error of the mesh sticks.

    The creep of the mesh can be told from slip only where half-plane theory of like bodies holds.
    Between unlike bodies, or bodies of two shapes, pressing alone makes nodes slip, and slowly so
    near the edge of stick.

    Parameters
    ----------
    problem
        the contact problem, whose interface is coupled, or not
    states
        the states of the whole path
    cycle_starts
        index of the state at which each revolution starts; what comes before them is the
        initial loading
    """
    if problem.interface.coupling is not None:
        return law_states(states)
    return visible_states(states, cycle_starts, problem.friction, problem.interface.imposed)


def law_states(states: Sequence[InterfaceState]) -> States:
    """(n_steps, n) states by the law, but for rounding: a node on the Coulomb limit that has not
    moved sticks.

    Parameters
    ----------
    states
        of the whole path; nothing has moved at the first of them
    """
    stored_states = np.stack([state.state for state in states])
    starts = range(0, len(states) - 1, _AT_ONCE)

    def slip_of_increments(start: int) -> Array:
        """(k, n) of the next `_AT_ONCE` increments at most: slip of all of a long record would take
        gigabytes.
        """
        return np.diff([state.slip for state in states[start : start + _AT_ONCE + 1]], axis=0)

    largest_slip = max(
        (float(np.abs(slip_of_increments(start)).max()) for start in starts), default=0.0
    )
    has_moved = np.zeros(stored_states.shape, dtype=bool)
    for start in starts:
        slip = slip_of_increments(start)
        later_steps = slice(start + 1, start + 1 + len(slip))
        has_moved[later_steps] = (
            slip_sign(stored_states[later_steps]) * slip > _ROUNDING * largest_slip
        )
    stored_states[(slip_sign(stored_states) != 0) & ~has_moved] = STICK
    return stored_states


def visible_states(
    states: Sequence[InterfaceState],
    cycle_starts: Sequence[int],
    friction: float,
    imposed: Array | None = None,
) -> States:
    """(n_steps, n) states as the user sees them: the law's, but a node that only creeps by the
    error of the mesh sticks.

    The load drives forward slip where dQ > f dP and reverse slip where -dQ > f dP: like half-planes
    slip there alone, each node of the slip zone, however slowly. At a distance from the middle of
    the stick zone bulk strain and tilt add their part to dQ and dP: in full stick both tractions
    are [d(P, Q)/pi - d(tilt, strain) (x - m)/A] over one and the same root, A = 2 in scaled
    variables. What the load does not drive has to be fast to count as slip.

    Parameters
    ----------
    states
        of the whole path
    cycle_starts
        index of the state at which each revolution starts; what comes before them is the
        initial loading
    friction
        coefficient f
    imposed
        (2, n, 3) gap and slip by a unit of the bulk stresses and of the tilt; None without any
    """
    stored_states = np.stack([state.state for state in states])
    rise = np.diff([state.loads for state in states], axis=0)
    change = np.maximum(np.abs(rise).sum(axis=1), 1e-300)
    n_nodes = len(states[0].state)
    # Some hundred increments at a time: arrays of all of a long record would take gigabytes.
    blocks = [
        slice(first_row, min(first_row + _AT_ONCE, len(rise)))
        for first_row in range(0, len(rise), _AT_ONCE)
    ]

    def sense_and_slip(steps: slice) -> tuple[Array, Array]:
        """Sense of slip by the law, and slip of the increments, (k, n) each."""
        block = states[steps.start : steps.stop + 1]
        slip = np.diff([state.values[3 : 3 + n_nodes] for state in block], axis=0)
        return slip_sign(stored_states[steps.start + 1 : steps.stop + 1]).astype(float), slip

    largest_sliding = np.zeros(len(rise))  # slip of the nodes that slide, in each increment
    largest_slip = 0.0  # of all nodes
    for steps in blocks:
        sense, slip = sense_and_slip(steps)
        largest_sliding[steps] = np.abs(slip * sense).max(axis=1)
        largest_slip = max(largest_slip, float(np.abs(slip).max()))
    starts = np.asarray(cycle_starts, dtype=int)
    revolution = np.searchsorted(starts, np.arange(len(rise)), side="right")
    speed = largest_sliding / change
    fastest = np.array(
        [speed[revolution == number].max(initial=0.0) for number in range(len(cycle_starts) + 1)]
    )
    least_slip = _CREEP * fastest[revolution] * change
    run = np.zeros(n_nodes)
    for steps in blocks:
        sense, slip = sense_and_slip(steps)
        slip[np.abs(slip) <= _ROUNDING * largest_slip] = 0.0
        runs = slip.copy()
        for step in range(len(runs)):  # slip in one direction without a stop, open or closed
            runs[step] += np.where(run * runs[step] > 0, run, 0.0)
            run = runs[step]
        view = stored_states[steps.start + 1 : steps.stop + 1]
        rise_of_p = rise[steps, 0, None]
        rise_of_q = rise[steps, 1, None]
        if imposed is not None:
            block = states[steps.start : steps.stop + 1]
            rise_of_imposed = np.diff([state.imposed for state in block], axis=0)
            of_gap, of_slip = _about_stick_zone(rise_of_imposed, imposed, view == STICK)
            rise_of_p = rise_of_p - np.pi / 2 * of_gap
            rise_of_q = rise_of_q + np.pi / 2 * of_slip
        is_driven = sense * rise_of_q > friction * rise_of_p
        slides = is_driven | (np.abs(slip) > least_slip[steps, None])
        for direction in (1, -1):
            in_direction = sense == direction
            distance = np.where(in_direction, direction * runs, 0.0)
            moved_on = distance > _MOVED * distance.max(axis=1, keepdims=True)
            view[in_direction & ~(slides & moved_on)] = STICK
    at_rest = stored_states[:1]
    at_rest[slip_sign(at_rest) != 0] = STICK  # of the first nothing has moved
    return stored_states


def _about_stick_zone(rise: Array, imposed: Array, sticks: Mask) -> tuple[Array, Array]:
    """Gap and slip of the nodes by a rise (k, 3) of bulk stresses and tilt, (k, n) each, counted
    from the middle of the stick zone; 0 where nothing sticks.

    `imposed` (2, n, 3) are gap and slip by a unit of each, `sticks` (k, n) the nodes that stick.
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
