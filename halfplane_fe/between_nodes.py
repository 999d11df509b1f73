r"""Edges between nodes: what W of a revolution has in excess because edges of contact and stick go
from node to node.

While a set of nodes is in contact the forces are linear in P. While a set sticks they are linear in
Q. Along the loads the discrete answer is a chain of chords, with a corner wherever a node touches
or starts to slide. The true answer is the smooth curve that the chain follows. Near an edge all
tractions are roots of the distance from it, so that all chains have one form. Let e be the place of
the edge, in elements. The chords exceed the curve by A g(e),

    g = v_k + (v_l - v_k) t - d^2 t (1 - t)/2,    t = (e - e_k)/d,

between the places e_k and e_l = e_k + d at which two neighbouring nodes k, l are met. The slope of
g falls by j_k where k is met. Quadratic elements have two kinds of nodes; d = D from a mid-side
node outwards to the next corner, and 1 - D from there to the next mid-side node. The mean of g is
zero. Then D and the difference V of the two values fix it all:

    v_mid + v_corner = [D^3 + (1 - D)^3]/6,    j_mid = 1/2 + V [1/D + 1/(1 - D)] = 1 - j_corner.

The place of the edge follows from the answer, as two distances in the load that moves it. The way
from the last node is its slip (or pressure) over the rate. The way to the next node is what that
lacks of the cone (or its gap) over the rate. The corner is the jump of the rates, which gives A.

While an edge moves on, g has no mean. What counts is where edges stand:

- that of permanent stick, where forward and reverse slip turn round: slip in excess, ds, under the
  pressure there, f p ds;
- that of contact, where P stays or turns round: pressure in excess, dp, along the slip, f dp ds,
  summed over the increments.

The rms of W over edges in 21 places, over W (h/a)^2, before and after, with elements of a/20 and of
a/40: Cattaneo and Mindlin 1.04 and 0.10, 1.06 and 0.08; hertz-paper 0.81 and 0.11, 0.83 and 0.21;
flat-rounded-paper 3.0 and 0.8, 2.6 and 0.5. What is left is of order (h/a)^(5/2), of a stick edge
that slows down as it comes to its turn on a smooth path, and of increments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from halfplane_fe.contact import ContactProblem, InterfaceState, nodal
from halfplane_fe.law import slip_sign
from scenes import OPEN, STICK
from scenes.array_types import Array, Mask, States

# D and V: least squares on Hertz' compression pressed through 40 elements.
_D = 0.566
_V = 0.0335
# rms of g over the edge's places.
_RMS = 0.0155
# Weight of a mid-side node over that of its neighbours, in elements of one size: 2, from one size
# to the next more or less.
_SIMPSON = (1.8, 2.2)
# Range of slip of a node over the largest of the revolution below which it sticks.
_STUCK = 1e-6
# Share of its own range within which a node has turned round.
_TURNED = 1e-6
# Count of work: of the last revolution, for what it had is taken off the dissipation.
TAKEN_OFF = "edges between nodes, taken off the dissipation"
# Nodes of a zone below which its edge is not far from another one.
_ZONE = 3


class Excess(NamedTuple):
    """Of the dissipation of a revolution, scaled.

    Attributes
    ----------
    value
        what the edges that stand between nodes add to it
    scatter
        rms of that over where they stand
    edges
        how many there are
    is_unplaced
        whether a zone sticks all along, and none of its edges is counted
    """

    value: float
    scatter: float
    edges: int
    is_unplaced: bool = False


def excess(problem: ContactProblem, states: Sequence[InterfaceState]) -> Excess:
    """What edges of stick and contact between nodes add to the dissipation of a cycle; first of
    `states` is the one before the cycle.

    An edge counts if its zones have three nodes or more, and if the elements around it are
    quadratic and of one size.
    """
    no_excess = Excess(0.0, 0.0, 0)
    problem.work.pop(TAKEN_OFF, None)
    if not problem.tangential:
        return no_excess
    slip = np.stack([state.slip for state in states])
    slip_range = np.ptp(slip, axis=0)
    is_closed = np.stack([state.closed for state in states])
    largest_range = np.max(slip_range, where=is_closed.any(axis=0), initial=0.0)
    sticks_all_along = is_closed.all(axis=0) & (slip_range <= _STUCK * largest_range)
    stick_zone = np.flatnonzero(sticks_all_along)
    if len(stick_zone) < _ZONE or np.diff(stick_zone).max() > 1:
        return no_excess
    at_stick_edges: list[_EdgeWork] = []
    at_contact_edges: list[_EdgeWork] = []
    for side in (1, -1):
        at_stick_edge = _at_stick_edge(problem, states, slip, sticks_all_along, side)
        if at_stick_edge is None:
            continue
        at_stick_edges.append(at_stick_edge)
        at_contact_edge = _at_contact_edge(problem, states, slip, side)
        if at_contact_edge is not None:
            at_contact_edges.append(at_contact_edge)
    all_edges = at_stick_edges + at_contact_edges
    problem.work[TAKEN_OFF] = len(all_edges)
    # the two edges of a zone mostly stand alike in their elements: their scatters add up
    scatter_of_all = math.hypot(
        sum(edge.scatter for edge in at_stick_edges),
        sum(edge.scatter for edge in at_contact_edges),
    )
    return Excess(
        value=sum(edge.work for edge in all_edges),
        scatter=scatter_of_all,
        edges=len(all_edges),
        is_unplaced=not all_edges,
    )


class _EdgeWork(NamedTuple):
    """Work in excess at an edge, and its rms over where the edge stands."""

    work: float
    scatter: float


def _at_stick_edge(
    problem: ContactProblem,
    states: Sequence[InterfaceState],
    slip: Array,
    sticks: Mask,
    side: int,
) -> _EdgeWork | None:
    """Work in excess, by the place of an edge between two nodes, at the edge of permanent stick on
    one side of x = 0; None where it does not count.

    Locked-in shear brings a node beside the edge nearer to the cone at one turn of the slip, and
    further from it at the other. So its distances at both turns are added.

    Parameters
    ----------
    problem
        the contact problem that the states solve
    states
        the states of a cycle
    slip
        (k, n) slip of the nodes at these states, scaled
    sticks
        (n,) nodes that stick throughout
    side
        1 for the right edge, -1 for the left one
    """
    leftmost, rightmost = np.flatnonzero(sticks)[[0, -1]].tolist()
    last_stuck = rightmost if side > 0 else leftmost
    first_stuck = leftmost if side > 0 else rightmost
    node = last_stuck + side
    opposite_node = first_stuck - side
    if not _regular(problem, node):
        return None
    slip_of_node = slip[:, node]
    slip_range = float(np.ptp(slip_of_node))
    signs = slip_sign(np.array([state.state[node] for state in states]))
    states_at_turns: dict[int, InterfaceState] = {}
    for sign in (1, -1):
        is_at_turn = sign * slip_of_node >= np.max(sign * slip_of_node) - _TURNED * slip_range
        turning_numbers = np.flatnonzero((signs == sign) & is_at_turn)
        if not len(turning_numbers) or not states[turning_numbers[-1]].is_complete:
            return None
        states_at_turns[sign] = states[turning_numbers[-1]]
    force_to_cone = sum(
        problem.friction * turning_state.pressure[last_stuck]
        - sign * turning_state.shear[last_stuck]
        for sign, turning_state in states_at_turns.items()
    )
    work_in_excess = 0.0
    scatter = 0.0
    n_loads = len(states[0].loads)
    for sign, turning_state in states_at_turns.items():
        # Nodes that have only reached the cone stick.
        states_at_turn = np.where(
            sticks & (turning_state.state != OPEN), STICK, turning_state.state
        ).astype(np.int8)
        is_sliding = slip_sign(states_at_turn) == sign
        sliding_beyond = is_sliding[node:] if side > 0 else is_sliding[: node + 1]
        if np.count_nonzero(sliding_beyond) < _ZONE - 1:
            return None
        slip_rates, pressure_rates, shear_rates, _ = nodal(
            problem.rates(states_at_turn, n_loads)[1]
        )
        cone_rate = problem.friction * pressure_rates[last_stuck] - sign * shear_rates[last_stuck]
        load_from_node = _load_to(slip_range, slip_rates[node])
        load_between_nodes = load_from_node + _load_to(force_to_cone, cone_rate)
        if not 0 < load_between_nodes < math.inf:
            return None
        excess_per_work, unit_work = _chord(
            problem, node, True, load_from_node / load_between_nodes, load_between_nodes
        )
        opposite_slides = 0 <= opposite_node < len(is_sliding) and bool(is_sliding[opposite_node])
        nodes = (node, opposite_node) if opposite_slides else (node,)

        def slip_by_load(states: States) -> Array:
            return np.asarray(nodal(problem.rates(states, n_loads)[1])[0])

        slip_jump = _jump(slip_by_load, states_at_turn, nodes, STICK)
        edge_work = problem.friction * float(turning_state.pressure @ slip_jump) * unit_work
        work_in_excess -= edge_work * float(excess_per_work)
        scatter += abs(edge_work) * _RMS
    return _EdgeWork(work_in_excess, scatter)


def _at_contact_edge(
    problem: ContactProblem, states: Sequence[InterfaceState], slip: Array, side: int
) -> _EdgeWork | None:
    """Work in excess, by the place of an edge between two nodes, at the edge of contact on its way
    on one side of x = 0; None where it does not count.

    Along each increment the pressure is linear in P, and no node touches or lets go.

    Parameters
    ----------
    states
        the states of a cycle
    slip
        (k, n) slip of the nodes at these states, scaled
    side
        1 for the right edge, -1 for the left one
    """
    n_loads = len(states[0].loads)
    rates: dict[bytes, Array] = {}

    def rates_by_load(state: States) -> Array:
        """(4, n) rates by P: of like bodies they depend on what is closed alone, of others they are
        those of full stick.
        """
        if problem.interface.coupling is not None:
            state = np.where(state != OPEN, STICK, OPEN).astype(np.int8)
        closed_key = (state != OPEN).tobytes()
        if closed_key not in rates:
            rates[closed_key] = nodal(problem.rates(state, n_loads)[0])
        return rates[closed_key]

    def pressure_by_load(state: States) -> Array:
        return np.asarray(rates_by_load(state)[1])

    for state in states:
        rates_by_load(state.state)
    work_in_excess = 0.0
    work_of_stays: dict[int, float] = {}  # by the node that the edge stands at
    slip_increments = np.abs(np.diff(slip, axis=0))
    for start, end, node_slips in zip(states[:-1], states[1:], slip_increments, strict=True):
        closed_nodes = np.flatnonzero(start.closed)
        node = int(closed_nodes[-1 if side > 0 else 0])
        opposite_node = int(closed_nodes[0 if side > 0 else -1])
        next_node = node + side
        if not node_slips.any():
            continue
        if not start.is_complete or not _regular(problem, node):
            return None
        if not 0 <= next_node < len(node_slips):
            return None
        _, pressure_rates, _, gap_rates = rates_by_load(start.state)
        load_from_node = _load_to(start.pressure[node], pressure_rates[node])
        load_between_nodes = load_from_node + _load_to(start.gap[next_node], gap_rates[next_node])
        if not 0 < load_between_nodes < math.inf:
            return None
        load_at_end = load_from_node + end.loads[0] - start.loads[0]
        share_at_start, share_at_end = (
            np.clip([load_from_node, load_at_end], 0.0, load_between_nodes) / load_between_nodes
        )
        shares = np.array([share_at_start, (share_at_start + share_at_end) / 2, share_at_end])
        excess_per_work, unit_work = _chord(problem, node, False, shares, load_between_nodes)
        nodes = (node, opposite_node) if _regular(problem, opposite_node) else (node,)
        pressure_jump = _jump(pressure_by_load, start.state, nodes, OPEN)
        edge_work = problem.friction * float(node_slips @ pressure_jump) * unit_work
        # Simpson's rule along the increment
        work_in_excess -= edge_work * float(excess_per_work @ [1, 4, 1]) / 6
        work_of_stays[node] = work_of_stays.get(node, 0.0) + abs(edge_work)
    # The way from node to node has no mean: what counts is the longest stay between two.
    return _EdgeWork(work_in_excess, max(work_of_stays.values(), default=0.0) * _RMS)


def _load_to(distance: float, rate: float) -> float:
    """How much load takes a node that far; infinite where load does not move it."""
    return float(distance) / abs(float(rate)) if rate else math.inf


def _jump(
    rates: Callable[[States], Array], state: States, nodes: tuple[int, ...], earlier_state: int
) -> Array:
    """Change of the rates (n,) when the first of one or two nodes left `earlier_state`: the mean
    over both orders in which two nodes may have left it.
    """
    node, *second_node = nodes
    jumps = []
    for nodes_back in {(), tuple(second_node)}:
        states_after = state.copy()
        states_after[list(nodes_back)] = earlier_state
        states_before = states_after.copy()
        states_before[node] = earlier_state
        jumps.append(rates(states_after) - rates(states_before))
    return np.asarray(sum(jumps) / len(jumps))


def _regular(problem: ContactProblem, node: int) -> bool:
    """Whether quadratic elements of one size are around a node, and its neighbours on both sides
    may touch.
    """
    weights = problem.interface.weights
    if not 2 <= node < len(weights) - 2:
        return False
    weights_of_kind = weights[node - 2 : node + 3 : 2].tolist()
    weights_beside = weights[node - 1 : node + 2 : 2].tolist()
    corner_weights, middle_weights = sorted((weights_of_kind, weights_beside), key=max)
    least_spacing, largest_spacing = _SIMPSON
    return least_spacing * max(corner_weights) <= min(middle_weights) and max(
        middle_weights
    ) <= largest_spacing * min(corner_weights)


def _chord(
    problem: ContactProblem, node: int, inwards: bool, share: Array | float, distance: float
) -> tuple[Array, float]:
    """For an edge that is a `share` t of the way between a node and the next, inwards or outwards:
    the dimensionless work in excess there, and the load over the jump of the rates that makes it
    work.

    `distance` is the load that takes the edge from the one node to the next.
    """
    is_corner = bool(problem.interface.weights[node] < problem.interface.weights[node - 1])
    v_of_both = (_D**3 + (1 - _D) ** 3) / 6
    v_of_corner = (v_of_both - _V) / 2
    v_of_middle = (v_of_both + _V) / 2
    jump_of_middle = 0.5 + _V * (1 / _D + 1 / (1 - _D))
    place_of_node = _D if is_corner == inwards else 1 - _D
    v_of_node = v_of_corner if is_corner else v_of_middle
    v_of_next = v_of_middle if is_corner else v_of_corner
    jump_of_node = 1 - jump_of_middle if is_corner else jump_of_middle
    t = np.asarray(share)
    excess_per_work = v_of_node + (v_of_next - v_of_node) * t - place_of_node**2 * t * (1 - t) / 2
    return excess_per_work, distance / (place_of_node * jump_of_node)
