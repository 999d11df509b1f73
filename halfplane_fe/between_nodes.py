r"""Edges between nodes: where the edge of permanent stick stands between two nodes, and what W of a
revolution has in excess because edges of contact and stick go from node to node.

While a set of nodes is in contact the forces are linear in P. While a set sticks they are linear in
Q. Along the loads the discrete answer is a chain of chords, with a kink wherever a node touches or
starts to slide. The true answer is the smooth curve that the chain follows. Near an edge all
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
lacks of the Coulomb limit (or its gap) over the rate. The change of the rates at the kink gives A.
An edge meets a corner node 0.053 elements before it is there, on its way outwards, and a mid-side
node D - 1/2 before that.

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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from halfplane_fe.contact import ContactProblem, InterfaceState, nodal_values
from halfplane_fe.interface import Interface
from halfplane_fe.law import force_to_limit, slip_sign
from scenes import OPEN, STICK
from scenes.array_types import Array, Indices, Mask, States

# D and V: least squares on Hertz' compression pressed through 40 elements. Distance of an edge from
# a corner node outwards when it meets that, in elements, which do not grow away from the edges:
# Hertz' contact, meshes of a/40 to a/160, and random half-planes at growths of 0.2 and 0.5.
_D = 0.566
_V = 0.0335
_CORNER_IS_MET = 0.053
_V_OF_BOTH = (_D**3 + (1 - _D) ** 3) / 6
_JUMP_OF_MIDDLE = 0.5 + _V * (1 / _D + 1 / (1 - _D))
# rms of g over the edge's places.
_RMS = 0.0155
# Shares of the distance of two nodes by which an edge between them is uncertain: one beyond a
# corner, one beyond a mid-side node, after both are corrected. By them it errs by 0.006 and 0.003
# in the median on the coarse mesh, by 0.003 and 0.002 on the default one. Seeds 501 and 701 to 703
# of benchmarks/covered.py values, as the next four.
_BEYOND_CORNER = 0.018
_BEYOND_MID_SIDE = 0.0085
# Of the square of how unevenly the load takes it on: the range of what nodes behind and ahead show.
# Where earlier loads have left shear, they show the opposite of each other.
_BY_UNEVENNESS = 0.35
# Of the correction itself, or of the largest one where it would be larger.
_BY_CORRECTION = 0.7
# Over the square of the nodes that the edge is from x = 0: of wedges it errs by 0.05 and more up to
# twelve nodes from their tip. And over the cube of the nodes that a stick edge has passed since
# slip began: 98 of 100 err by up to 0.035 beside the first one, by no more than others from the
# second one on.
_BY_NEAR_MIDDLE = 3.0
_BY_FEW_NODES = 0.06
# Share of the distance of two nodes, over how much farther a small load takes an edge of stick than
# one of contact (`_leverage`): 0.0015 to 0.002 in the median where that is 6 to 100, on both
# presets. Seeds 289, 703 and 708 of benchmarks/covered.py values.
_BY_LEVERAGE = 0.002
# Share of how uncertain a stick edge was on its way to a node that is left where it has just passed
# that. Beyond an older stick edge the nodes behind it soon show nothing uneven, while the edge is
# still 0.4 of their distance beside its place: up to 17 times what was stated without it. As the
# nodes ahead count too, it need not be 0.4: what was stated by it was 13 times the error in the
# median.
_LEFT_AT_NEXT_NODE = 0.2
# Distances of nodes that a stick edge moves in one increment above which it jumps.
JUMP = 6.0
# Factor on that at the edges of permanent stick: their two turning points err less, but beyond
# corners they are not corrected.
_AT_TURNS = 0.9
# Share of the distance of two nodes, over a logarithm, by which an edge errs beyond a mid-side
# node: the slope is 0.12 to 0.15 on both presets. Putting that right takes the median error from
# 0.0045 to 0.0019 of the distance on the default mesh.
# Seeds 284 to 286 and 401 to 405 of benchmarks/covered.py values.
_OFF_MID_SIDE = 0.13
# The same beyond a corner: of the difference between the first and the third node behind it, and
# of that between the first node behind it and those ahead. Edges of contact and of stick on both
# presets have slopes of 0.18 to 0.22 and 0.10 to 0.17. It takes the median error from 0.0085 to
# 0.0060 of the distance on the coarse mesh.
_OFF_CORNER = (0.19, 0.15)
# Beyond this share it is no error of the elements, and nothing is put right: where it would be
# more, edges err by 0.01 in the median without it, and by 0.06 to 0.3 with it. The pressure at the
# edge of a bonded rigid body swings, and its nodes would give 0.8.
_MOST_CORRECTION = 0.045
# Closed nodes on its side of x = 0 below which no load locates a contact edge.
_CLOSED = 6
# Load since an edge met each of three nodes behind the last one, less that of the last one, over
# the load between two nodes, by whether the last one is a corner: medians of 60,000 edges of
# contact and stick, which agree to 0.5 %.
_LOADS_BEHIND = {True: (2.35, 4.95, 6.95), False: (2.47, 3.80, 5.55)}
# Load from the first node beyond the last one to the second one, likewise: medians of 37,000 edges
# of contact and 48,000 of stick.
_LOAD_AHEAD = {True: 0.74, False: 0.56}
# Nodes that must stick.
_STICK_ZONE = 8
# Share of the even load that counts as none.
_LEAST_SHARE = 1e-3
# Distances of nodes from the middle between two beyond which an edge is not theirs.
_SAME_EDGE = 4.0
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


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge of contact or of stick between two nodes, located by the load that moves it: P the
    edge of contact, Q that of stick. All is scaled.

    Forces, gap and slip of both nodes locate it to a fiftieth of their distance. Which of them
    slips or touches locates it to half of that. It takes the rates by the load, which only states
    of the run have. An increment has no sides: it lands on the first of all nodes
    (`stepping.next_event`).

    Attributes
    ----------
    interface
        whose nodes they are
    side
        1 on the right of x = 0, -1 on the left
    node, next_node
        which it met last, and which it meets next
    load_from_node
        change of load that has taken the edge from `node` to its place
    load_between
        change of load that takes it all the way from `node` to `next_node`
    """

    interface: Interface
    side: int
    node: int
    next_node: int
    load_from_node: float
    load_between: float

    @classmethod
    def of_contact(
        cls,
        problem: ContactProblem,
        side: int,
        node: int,
        state: InterfaceState,
        rates_by_p: Array,
    ) -> Edge:
        """The edge of contact between a closed node and the open one farther out.

        The change of P back to the closed node is its nodal force over its rate. That to the open
        node is its gap over its rate. All is scaled.

        Parameters
        ----------
        problem
            the contact problem, with the nodes of its `interface`
        side
            1 on the right of x = 0, -1 on the left
        node
            outermost closed node; the next one outwards is open
        state
            nodal forces and gaps at the instant
        rates_by_p
            (4, n) derivatives by P of slip, normal force, shear force and gap of the nodes
        """
        next_node = node + side
        _, pressure_rates, _, gap_rates = rates_by_p
        load_from_node = _load_to(state.pressure[node], pressure_rates[node])
        load_to_next_node = _load_to(state.gap[next_node], gap_rates[next_node])
        load_between = load_from_node + load_to_next_node
        return cls(problem.interface, side, node, next_node, load_from_node, load_between)

    @classmethod
    def of_stick(
        cls,
        problem: ContactProblem,
        side: int,
        last_stuck: int,
        slip_beside_edge: SlipBesideEdge,
        rates_by_q: Array,
    ) -> Edge:
        """The edge of stick between the last stuck node and the first sliding one, as it moves
        inwards.

        The change of Q since the sliding node was met is its slip over its rate. That to the stuck
        node is its force to the Coulomb limit, f p - s q, over its rate. For permanent stick
        `slip_beside_edge` has both between the two turning points of slip: locked-in shear drops
        out. At an instant between them it does not. Beside an older stick edge the place is then
        wrong by up to the distance of the nodes.

        # notation: p normal and q shear force of a node, s sense of slip, f friction

        Parameters
        ----------
        problem
            the contact problem: nodes of its `interface`, and friction f
        side
            1 on the right of x = 0, -1 on the left
        last_stuck
            outermost node of the stick zone; the next one outwards slides
        slip_beside_edge
            sense of slip, slip of the first sliding node, and force of the last stuck one to the
            Coulomb limit
        rates_by_q
            (4, n) derivatives by Q of slip, normal force, shear force and gap of the nodes
        """
        first_sliding = last_stuck + side  # number of that node
        slip_rates, pressure_rates, shear_rates, _ = rates_by_q
        force_rates = force_to_limit(
            pressure_rates, shear_rates, slip_beside_edge.sense, problem.friction
        )
        load_from_node = _load_to(slip_beside_edge.slip, slip_rates[first_sliding])
        load_to_last_stuck = _load_to(slip_beside_edge.force_to_limit, force_rates[last_stuck])
        load_between = load_from_node + load_to_last_stuck
        return cls(problem.interface, side, first_sliding, last_stuck, load_from_node, load_between)

    @property
    def is_moved(self) -> bool:
        """Whether a finite change of load takes the edge from `node` to `next_node`."""
        return 0 < self.load_between < math.inf

    def fraction_passed(self, change_of_load: float = 0.0) -> float:
        """Where the edge is after a change of load, as a fraction 0 to 1 of the way from `node` to
        `next_node`.

        `load_between` is the load that takes it all that way, `load_from_node` the part of it that
        has taken it to its present place.
        """
        return float(
            np.clip(self.load_from_node + change_of_load, 0.0, self.load_between)
            / self.load_between
        )

    @property
    def place(self) -> float:
        """x of the edge, over the half-width."""
        place_at_node, place_at_next_node = self._ends
        return place_at_node + self.fraction_passed() * (place_at_next_node - place_at_node)

    @property
    def spacing(self) -> float:
        """Distance of the edge's places when it meets the two nodes, over the half-width."""
        place_at_node, place_at_next_node = self._ends
        return abs(place_at_next_node - place_at_node)

    @property
    def _ends(self) -> tuple[float, float]:
        """x of the edge when it meets `node`, and when it meets the next, over the half-width."""
        return (
            place_when_met(self.interface, self.node, self.side),
            place_when_met(self.interface, self.next_node, self.side),
        )

    def dimensionless_excess(self, fraction: ArrayLike) -> Array:
        """Dimensionless excess work g of a mesh at fractions t of the way of an edge from `node` to
        `next_node`: that of a chain of chords over the smooth curve that it follows.

            g = v_k + (v_l - v_k) t - d^2 t (1 - t)/2

        The mean of g over all places of an edge is zero. Quadratic elements have two kinds of
        nodes, corners and mid-side nodes.

        # notation: v_k, v_l values at both nodes; d distance of the edge's places at them, over
        # the element
        """
        # _V_OF_BOTH: sum of the excess at a corner and at a mid-side node; _V: their difference
        v_of_corner = (_V_OF_BOTH - _V) / 2
        v_of_mid_side = (_V_OF_BOTH + _V) / 2
        v_of_node, v_of_next_node = (
            (v_of_corner, v_of_mid_side) if self._is_at_corner else (v_of_mid_side, v_of_corner)
        )
        t = np.asarray(fraction)
        return np.asarray(
            v_of_node
            + (v_of_next_node - v_of_node) * t
            - self._spacing_in_elements**2 * t * (1 - t) / 2
        )

    @property
    def load_over_rate_jump(self) -> float:
        """Load between the nodes over the dimensionless change of rates at `node`, j_k d: times a
        change of work by load, and times the dimensionless excess g, it is the excess work.

        # notation: j_k by how much the slope of g falls at the node, d distance of the edge's
        # places at both nodes, over the element
        """
        jump_of_node = 1 - _JUMP_OF_MIDDLE if self._is_at_corner else _JUMP_OF_MIDDLE
        return self.load_between / (self._spacing_in_elements * jump_of_node)

    @property
    def _is_at_corner(self) -> bool:
        """Whether the node that the edge met last is a corner of elements, not a mid-side node."""
        return _is_corner(self.interface, self.node)

    @property
    def _spacing_in_elements(self) -> float:
        """Distance d of the edge's places when it meets its two nodes, over the element: D, a
        little more than half, from a mid-side node outwards to the next corner, and 1 - D from
        there to the next mid-side node.
        """
        is_inwards = (self.next_node - self.node) * self.side < 0
        return _D if self._is_at_corner == is_inwards else 1 - _D


class SlipBesideEdge(NamedTuple):
    """Slip and force to the Coulomb limit beside a stick edge, at an instant, or from one turning
    point of the slip to the other; scaled.

    Attributes
    ----------
    sense
        of the slip, 1 or -1
    slip
        of the first sliding node since it began to slide, or from one turning point to the other
    force_to_limit
        f p - s q of the last stuck node (s the sense), or the sum of that at both turning points
    """

    sense: int
    slip: float
    force_to_limit: float


def place_when_met(interface: Interface, node: int, side: int) -> float:
    """Place x of an edge of contact or stick when it meets a node: a small part of an element
    inside a corner, a larger part inside a mid-side node. `side` of x = 0 is 1 (right) or -1
    (left).
    """
    x = interface.x
    # in elements, whose size is the distance of the two neighbours of the node
    distance_before_node = (
        _CORNER_IS_MET if _is_corner(interface, node) else _CORNER_IS_MET + _D - 0.5
    )
    return float(x[node] - side * distance_before_node * abs(x[node + 1] - x[node - 1]))


def _is_corner(interface: Interface, node: int) -> bool:
    """Whether a node of quadratic elements is a corner, not a mid-side one: corners stand for less
    of the face than the nodes beside them.
    """
    return bool(interface.face_lengths[node] < interface.face_lengths[node - 1])


class EdgesByLoad(NamedTuple):
    """Edges of contact or of stick of k instants by the load that moves them, left and right.

    Attributes
    ----------
    last_node
        (k, 2) last node that touches, or sticks; -1 where no load locates an edge
    places
        (k, 2) of the edge between it and the next one, scaled
    uncertainty
        (k, 2) how far each may be from the true one, by the mesh
    """

    last_node: Indices
    places: Array
    uncertainty: Array

    @classmethod
    def nowhere(cls, n_instants: int) -> EdgesByLoad:
        """Edges of k instants at none of which a load locates an edge: -1 for nodes, NaN for places
        and their uncertainty.
        """
        shape = (n_instants, 2)
        return cls(np.full(shape, -1), np.full(shape, np.nan), np.full(shape, np.nan))

    @classmethod
    def joined(cls, parts: Sequence[EdgesByLoad]) -> EdgesByLoad:
        """Edges at consecutive instants, from several objects with some of these instants."""
        return cls(*(np.concatenate(values) for values in zip(*parts, strict=True)))

    def at(self, rows: Indices | slice) -> EdgesByLoad:
        """Edges at those of the k instants that `rows` picks."""
        return EdgesByLoad(self.last_node[rows], self.places[rows], self.uncertainty[rows])

    def mirrored(self, middle: int) -> EdgesByLoad:
        """Edges on both sides from the right ones of a half that was solved alone; the left ones
        are mirror images. Its first node is number `middle` of all nodes.
        """
        right_last_node = self.last_node[:, 1:]
        outward_signs = np.array([-1, 1])
        return EdgesByLoad(
            last_node=np.where(right_last_node < 0, -1, middle + outward_signs * right_last_node),
            places=outward_signs * self.places[:, 1:],
            uncertainty=np.repeat(self.uncertainty[:, 1:], 2, axis=1),
        )

    def put(
        self, row: int, last_node: int, edge: Edge, unevenness: Array, uncertainty_share: float
    ) -> None:
        """Store the place and the uncertainty of an edge at one instant, in the arrays of this
        object.

        Parameters
        ----------
        row
            number of the instant
        last_node
            last node of the zone that ends at the edge
        edge
            between this node and the next, located by the load
        unevenness
            (3,) how unevenly the load takes it on, by nodes behind it; or (4,) with the nodes
            ahead: its place is corrected by that
        uncertainty_share
            uncertainty over the distance of the edge's places at both nodes; 1 at most
        """
        column = 0 if edge.side < 0 else 1
        self.last_node[row, column] = last_node
        self.places[row, column] = _place_put_right(edge, last_node, unevenness)
        self.uncertainty[row, column] = edge.spacing * min(uncertainty_share, 1.0)


def contact_by_load(
    problem: ContactProblem, contact_states: Sequence[InterfaceState]
) -> EdgesByLoad:
    """Left and right edge of contact at k instants, located between two nodes by the load P that
    moves it, with an uncertainty; none where P is not positive, where fewer than six nodes touch on
    a side, where elements are not quadratic, and where no finite load moves the edge.

    Parameters
    ----------
    problem
        the contact problem, with the derivatives of all nodal values by the loads (`rates`)
    contact_states
        the k contact states
    """
    # None yet; `put` stores one at an instant.
    edges_by_load = EdgesByLoad.nowhere(len(contact_states))
    for row, state in enumerate(contact_states):
        if not state.normal_load > 0:
            continue
        for side in (-1, 1):  # left and right of x = 0
            nodes_inwards = _closed_nodes_inwards(problem, state, side)  # the outermost first
            if len(nodes_inwards) < _CLOSED:
                continue
            last_closed_node = int(nodes_inwards[0])
            if not _is_quadratic(problem, last_closed_node):
                continue

            # Place by pressure, gap and their rates; uncertainty as a share of the node distance.
            rates_by_p = nodal_values(
                problem.rates(state.node_states, len(state.loads))[0]
            )  # cached
            contact_edge = Edge.of_contact(problem, side, last_closed_node, state, rates_by_p)
            if contact_edge.is_moved:  # a finite load takes it to the next node
                _, pressure_rates, _, gap_rates = rates_by_p
                unevenness = np.append(
                    _unevenness(contact_edge, last_closed_node, state.pressure, pressure_rates),
                    _unevenness_ahead(contact_edge, last_closed_node, state.gap, gap_rates),
                )
                uncertainty_share = math.hypot(
                    *_shares_of_spacing(contact_edge, last_closed_node, unevenness)
                )
                edges_by_load.put(
                    row, last_closed_node, contact_edge, unevenness, uncertainty_share
                )
    return edges_by_load


def stick_by_load(
    problem: ContactProblem,
    contact_states: Sequence[InterfaceState],
    travels: Array,
    passed_nodes: dict[int, PassedNodes],
) -> EdgesByLoad:
    """Left and right edge of the stick zone at k instants, located between two nodes by the load Q
    that takes it inwards, with an uncertainty; none where no load does, where elements are not
    quadratic, and where fewer than eight nodes stick behind the slip zone.

    Where shear moves away from the Coulomb limit the edge goes outwards, as between unlike bodies
    that are pressed: there no load locates it.

    Parameters
    ----------
    problem
        the contact problem, with friction and the derivatives of nodal values by the loads
    contact_states
        (k + 1,) contact states: the one before, and k that follow
    travels
        (k, n) distance that each node has slipped since it last stuck or turned round
    passed_nodes
        by side (1 on the right of x = 0, -1 on the left), how uncertain the edge was between the
        nodes that it has passed so far; it is brought up to the last state
    """
    edges_by_load = EdgesByLoad.nowhere(len(travels))  # none yet; `put` stores one at an instant
    if not problem.has_shear:
        return edges_by_load
    for row, (state_before, state, travel) in enumerate(
        zip(contact_states[:-1], contact_states[1:], travels, strict=True)
    ):
        for side in (-1, 1):  # left and right of x = 0
            # last node that sticks, and number of nodes that the edge has passed since slip began
            last_stuck_node, n_nodes_passed = _last_stuck_and_nodes_passed(
                problem, state, travel, side
            )
            if not n_nodes_passed:
                passed_nodes[side] = PassedNodes()
                continue
            if not _is_quadratic(problem, last_stuck_node + side):
                continue
            stick_edge, unevenness = _stick_edge_and_unevenness(
                problem, state, travel, side, last_stuck_node
            )
            # `is_moved`: a finite load takes it to the next node
            if stick_edge.is_moved and _comes_to_limit(problem, state_before, state, stick_edge):
                uncertainty_share, passed_nodes[side] = _uncertainty_share_of_stick_edge(
                    problem, state, stick_edge, unevenness, passed_nodes[side], n_nodes_passed
                )
                edges_by_load.put(row, last_stuck_node, stick_edge, unevenness, uncertainty_share)
    return edges_by_load


def _uncertainty_share_of_stick_edge(
    problem: ContactProblem,
    state: InterfaceState,
    stick_edge: Edge,
    unevenness: Array,
    record_before: PassedNodes,
    n_nodes_passed: int,
) -> tuple[float, PassedNodes]:
    """Uncertainty of the place of a stick edge at an instant, over the distance of its two nodes,
    and a record of how uncertain it was between the nodes that it has passed up to then.

    The uncertainty is the root of the sum of the squares of these parts:

    - by the kind of the last node that sticks, corner or mid-side;
    - by how near x = 0 is;
    - by the correction of the place;
    - by how few nodes the edge has passed since slip began, or since it last jumped;
    - by how much farther a small load takes it than an edge of contact (`_leverage`);
    - by how unevenly the load moves it, or by what is left of its earlier uncertainty, the larger
      one. That is the one between the nodes that it has passed, or the one by the first sliding
      node, which may have begun to slide late.

    Parameters
    ----------
    problem
        the contact problem: friction, and derivatives of nodal values by the loads (`rates`)
    state
        contact state at the instant
    stick_edge
        between the first sliding node and the last one that sticks (`next_node`)
    unevenness
        (3,) how unevenly the load moves the edge, by three nodes behind it; or (4,) with the nodes
        ahead
    record_before
        how uncertain it was between the nodes that it had passed at the instant before
    n_nodes_passed
        number of nodes that it has passed since slip began
    """
    *other_shares, share_by_unevenness = _shares_of_spacing(
        stick_edge, stick_edge.next_node, unevenness
    )
    share_by_late_start = _share_by_late_start(unevenness[:3])
    record_now = record_before.followed_by(stick_edge.next_node, n_nodes_passed).with_share(
        max(min(share_by_unevenness, 1.0), share_by_late_start)
    )
    # The uncertainty that the edge had as it met the sliding node fades linearly, to 0 where it
    # meets the next one; not where it has passed several nodes unseen.
    fading = 1 - stick_edge.fraction_passed()
    share_left = max(
        share_by_late_start * fading,
        record_now.share_left * (1.0 if record_now.has_passed_several else fading),
    )
    # _BY_FEW_NODES: fitted share where slip began a single node away
    share_by_few_nodes = _BY_FEW_NODES / record_now.n_nodes_since_jump(n_nodes_passed) ** 3
    uncertainty_share = math.hypot(
        *other_shares,
        share_by_few_nodes,
        # _BY_LEVERAGE: fitted share
        _BY_LEVERAGE * _leverage(problem, state, stick_edge),
        max(share_by_unevenness, share_left),
    )
    return uncertainty_share, record_now


def _leverage(problem: ContactProblem, state: InterfaceState, stick_edge: Edge) -> float:
    """How much farther a small change of the load takes an edge of stick than one of contact: f
    times the load that takes the edge of contact some way, over the load that takes that of stick
    as far; 0 where no finite load moves the edge of contact.

    It is about 1/2 where Q moves under a constant P. Under loads that nearly follow Q = f P the
    shear lacks little of the Coulomb limit wherever the contact sticks, and small loads take the
    edge far. The load of a contact edge at the place of the stick edge is that at its own place, in
    proportion to the distance from x = 0, as in Hertz' contact.

    Parameters
    ----------
    problem
        the contact problem: friction, and derivatives of nodal values by the loads (`rates`)
    state
        contact state: nodal forces and gaps, and open, stick or slip of the nodes
    stick_edge
        the edge of stick; its `side` is 1 on the right of x = 0, -1 on the left
    """
    last_closed_node = int(_closed_nodes_inwards(problem, state, stick_edge.side)[0])
    if not 2 <= last_closed_node < len(state.gap) - 2:
        return 0.0
    rates_by_p = nodal_values(problem.rates(state.node_states, len(state.loads))[0])  # cached
    contact_edge = Edge.of_contact(problem, stick_edge.side, last_closed_node, state, rates_by_p)
    if not contact_edge.is_moved or contact_edge.place == 0:
        return 0.0
    contact_load_over_way = contact_edge.load_between / contact_edge.spacing
    stick_load_over_way = stick_edge.load_between / stick_edge.spacing
    ratio_of_places = abs(stick_edge.place / contact_edge.place)
    return problem.friction * contact_load_over_way / stick_load_over_way * ratio_of_places


class PassedNodes(NamedTuple):
    """How uncertain a stick edge was between the nodes that it has passed on its way inwards.

    Attributes
    ----------
    last_stuck_node
        node that the edge comes to; -1 before it has come to any
    landing_node
        the same where it last jumped to; -1 where it has not jumped since slip began
    largest_share
        how uncertain it has been on the way to this node, at most, over the distance of two nodes
    share_left
        what is left, where the edge has met the node before, of how uncertain it was on the way to
        that one; over the same distance
    has_passed_several
        whether it passed more than one node in the increment that took it on its way to this one
    """

    last_stuck_node: int = -1
    landing_node: int = -1
    largest_share: float = 0.0
    share_left: float = 0.0
    has_passed_several: bool = False

    def followed_by(self, last_stuck_node: int, n_nodes_passed: int) -> PassedNodes:
        """The uncertainty at the next instant, at which the edge moves towards the node
        `last_stuck_node`; `n_nodes_passed` is the number that it has passed since slip began.

        Where the edge goes from one node to the next, a part of its earlier uncertainty is left.
        Where it passes several nodes in one increment, all of it is left: no instant shows how it
        passed them.
        """
        if last_stuck_node == self.last_stuck_node:
            return self
        is_first = self.last_stuck_node < 0
        n_nodes_of_increment = (
            n_nodes_passed if is_first else abs(last_stuck_node - self.last_stuck_node)
        )
        # JUMP: most nodes that an edge passes in one increment without a jump
        landing_node = last_stuck_node if n_nodes_of_increment > JUMP else self.landing_node
        # _LEFT_AT_NEXT_NODE: share that is left at the next node
        has_passed_several = n_nodes_of_increment > 1
        part_left = 1.0 if has_passed_several else _LEFT_AT_NEXT_NODE
        share_left = part_left * max(self.largest_share, self.share_left)
        return PassedNodes(last_stuck_node, landing_node, 0.0, share_left, has_passed_several)

    def with_share(self, share: float) -> PassedNodes:
        """The same with the uncertainty of a further instant, at which the edge is uncertain by a
        `share` of the distance of two nodes.
        """
        return self._replace(largest_share=max(self.largest_share, share))

    def n_nodes_since_jump(self, n_nodes_passed: int) -> int:
        """Number of nodes that the edge has passed since it last jumped, or since slip began:
        `n_nodes_passed`.
        """
        if self.landing_node < 0:
            return n_nodes_passed
        return min(n_nodes_passed, abs(self.last_stuck_node - self.landing_node) + 1)


def _is_quadratic(problem: ContactProblem, node: int) -> bool:
    """Whether corners and mid-side nodes take turns around a node, as quadratic elements of any
    sizes have them; False where fewer than two nodes are on either side.
    """
    if not 2 <= node < len(problem.interface.face_lengths) - 2:
        return False
    if _has_equal_elements(problem, node):
        return True
    kinds = {_is_corner(problem.interface, neighbour) for neighbour in (node - 1, node + 1)}
    return kinds == {not _is_corner(problem.interface, node)}


def _comes_to_limit(
    problem: ContactProblem,
    state_before: InterfaceState,
    state_after: InterfaceState,
    stick_edge: Edge,
) -> bool:
    """Whether the edge of stick goes inwards: the shear of the last node that sticks has come
    nearer to the Coulomb limit from one contact state (`state_before`) to the next.

    Of `stick_edge` the `node` slides, the `next_node` is the last one that sticks. The force to the
    limit is f p - s q, s the sense of slip.
    """
    sense = int(slip_sign(state_after.node_states[stick_edge.node]))
    force_before, force_after = (
        force_to_limit(
            state.pressure[stick_edge.next_node],
            state.shear[stick_edge.next_node],
            sense,
            problem.friction,
        )
        for state in (state_before, state_after)
    )
    return bool(force_after < force_before)


def _closed_nodes_inwards(problem: ContactProblem, state: InterfaceState, side: int) -> Indices:
    """Numbers of the nodes that touch on one side of x = 0 (1 right, -1 left), from the outermost
    one inwards.
    """
    is_on_side = state.is_closed & (side * problem.interface.x >= 0)
    return np.flatnonzero(is_on_side)[::-side]


def _last_stuck_and_nodes_passed(
    problem: ContactProblem, state: InterfaceState, travel: Array, side: int
) -> tuple[int, int]:
    """The last node that sticks behind the outermost slip zone on one side of x = 0, and how many
    nodes the edge of stick has passed since slip began; -1 and 0 where no node slides or fewer than
    eight nodes stick behind the slip zone.

    Slip began beside the node that has come farthest.

    Parameters
    ----------
    problem
        the contact problem, with the places of the nodes
    state
        contact state: nodes that touch, stick, slide
    travel
        (n,) distance that each node has slipped since it last stuck or turned round
    side
        1 on the right of x = 0, -1 on the left
    """
    nodes_inwards = _closed_nodes_inwards(problem, state, side)  # the outermost first
    is_sliding = slip_sign(state.node_states[nodes_inwards]) != 0
    if not is_sliding.any():
        return -1, 0

    # Positions in that order: begin of the slip zone, and of the stick zone behind it.
    first_sliding_position = int(np.argmax(is_sliding))  # nodes that have just come to touch stick
    first_stuck_position = first_sliding_position + int(
        np.argmin(is_sliding[first_sliding_position:])
    )
    stick_zone = slice(first_stuck_position, first_stuck_position + _STICK_ZONE)
    if len(nodes_inwards[stick_zone]) < _STICK_ZONE or is_sliding[stick_zone].any():
        return -1, 0

    farthest_position = first_sliding_position + int(
        np.argmax(np.abs(travel[nodes_inwards[first_sliding_position:first_stuck_position]]))
    )
    return int(nodes_inwards[first_stuck_position]), first_stuck_position - farthest_position


def _stick_edge_and_unevenness(
    problem: ContactProblem, state: InterfaceState, travel: Array, side: int, last_stuck_node: int
) -> tuple[Edge, Array]:
    """The stick edge on its way inwards to the node `last_stuck_node`, and how unevenly the load Q
    moves it, 0 where evenly: by three sticking nodes, and by the two sliding ones that it has
    passed last, (4,); (3,) where it has passed a single node.

    Parameters
    ----------
    problem
        the contact problem: friction, and derivatives of nodal values by the loads (`rates`)
    state
        contact state: nodal forces, and open, stick or slip of the nodes
    travel
        (n,) distance that each node has slipped since it last stuck or turned round
    side
        1 on the right of x = 0, -1 on the left
    last_stuck_node
        outermost node of the stick zone; the next one outwards slides
    """
    first_sliding_node = last_stuck_node + side
    sense = int(slip_sign(state.node_states[first_sliding_node]))
    # by Q, (4, n): slip, pressure, shear and gap
    rates_by_q = nodal_values(problem.rates(state.node_states, len(state.loads))[1])
    slip_rates, pressure_rates, shear_rates, _ = rates_by_q
    # f p - s q of the nodes (n,), s the sense of slip, and its derivative by Q
    forces_to_limit = force_to_limit(state.pressure, state.shear, sense, problem.friction)
    rates_to_limit = force_to_limit(pressure_rates, shear_rates, sense, problem.friction)
    slip_beside_edge = SlipBesideEdge(
        sense, sense * float(travel[first_sliding_node]), float(forces_to_limit[last_stuck_node])
    )
    edge = Edge.of_stick(problem, side, last_stuck_node, slip_beside_edge, rates_by_q)
    unevenness_behind = _unevenness(edge, last_stuck_node, forces_to_limit, rates_to_limit)
    # by the nodes ahead too, unless the edge has passed a single node
    if slip_sign(state.node_states[first_sliding_node + side]) != sense:
        return edge, unevenness_behind
    unevenness_ahead = _unevenness_ahead(edge, last_stuck_node, sense * travel, slip_rates)
    return edge, np.append(unevenness_behind, unevenness_ahead)


def _unevenness(edge: Edge, last_node: int, nodal_forces: Array, nodal_force_rates: Array) -> Array:
    """How unevenly the load moves an edge of contact or stick, (3,), by three nodes behind it: 0
    where it does so evenly, infinite where it does not move the edge at all.

    Force over rate of a node behind the edge is the load from the meeting of both to now, if the
    rate stays. While the load moves the edge evenly, that of each node exceeds that of the last one
    by a known multiple of the load between two nodes (`_LOADS_BEHIND`). Near the start of a
    loading, an older stick edge, a kink of the profile, or larger elements it does not. The result
    is the logarithm of the ratio of both.

    Parameters
    ----------
    edge
        `load_between` is the load that takes it from its last node to the next; `side` is 1 on the
        right of x = 0, -1 on the left
    last_node
        of the zone that ends at the edge
    nodal_forces, nodal_force_rates
        (n,) nodal force that is zero at the edge, and its derivative by the load: the pressure at
        an edge of contact, f p - s q at one of stick
    """
    # of the load between two nodes
    even_multiples = np.array(_LOADS_BEHIND[_is_corner(edge.interface, last_node)])
    if not edge.is_moved:  # no finite load takes it to the next node
        return np.full(len(even_multiples), math.inf)
    nodes_behind = last_node - edge.side * np.arange(len(even_multiples) + 1)
    loads_since_met = np.array(
        [_load_to(max(nodal_forces[k], 0.0), nodal_force_rates[k]) for k in nodes_behind.tolist()]
    )
    ratios = (loads_since_met[1:] - loads_since_met[0]) / (edge.load_between * even_multiples)
    # _LEAST_SHARE: least ratio, so that its logarithm is finite
    return np.asarray(np.log(np.maximum(ratios, _LEAST_SHARE)))


def _unevenness_ahead(
    edge: Edge, last_node: int, gap_or_slip: Array, gap_or_slip_rates: Array
) -> float:
    """How unevenly the load moves an edge of contact or stick, by the two nodes ahead, beyond its
    zone: 0 where it does so evenly, infinite where it does not move the edge at all.

    Gap over rate of an open node is the load until the edge meets it, slip over rate of a sliding
    one the load since then. That of the second node exceeds that of the first one by a known share
    of the load between two nodes (`_LOAD_AHEAD`). The result is the logarithm of the ratio of both.
    It shows an edge that comes to its turn, or to shear that earlier loads have left, where the
    nodes behind it do not.

    Parameters
    ----------
    edge
        `load_between` is the load that takes it from one of its nodes to the other; `side` is 1 on
        the right of x = 0, -1 on the left
    last_node
        of the zone that ends at the edge
    gap_or_slip, gap_or_slip_rates
        (n,) gap at an edge of contact, slip at one of stick, and its derivative by the load
    """
    if not edge.is_moved:  # no finite load takes it to the next node
        return math.inf
    load_to_first, load_to_second = (
        _load_to(max(gap_or_slip[node], 0.0), gap_or_slip_rates[node])
        for node in (last_node + edge.side, last_node + 2 * edge.side)
    )
    even_load = _LOAD_AHEAD[_is_corner(edge.interface, last_node)] * edge.load_between
    # _LEAST_SHARE: least ratio, so that its logarithm is finite
    return math.log(max((load_to_second - load_to_first) / even_load, _LEAST_SHARE))


def _place_put_right(edge: Edge, last_node: int, unevenness: Array) -> float:
    """Place x of an edge by the load, corrected by how the nodes around it differ (`_correction`);
    scaled. Where that is more than a small share of the distance of two nodes, it is no error of
    the elements, and nothing is corrected.

    Parameters
    ----------
    edge
        between two nodes; `spacing` is the distance of its places at them, `side` 1 on the right of
        x = 0, -1 on the left
    last_node
        last node of the zone that ends at the edge
    unevenness
        (3,) how unevenly the load moves the edge, by the nodes behind it: 0 where evenly; or (4,)
        with that by the nodes ahead
    """
    correction = _correction(edge, last_node, unevenness)
    # _MOST_CORRECTION: largest share of the distance
    if abs(correction) > _MOST_CORRECTION:
        return edge.place
    return edge.place + edge.side * edge.spacing * correction


def _correction(edge: Edge, last_node: int, unevenness: Array) -> float:
    """Correction of the place of an edge by the load, outwards, over the distance of its two nodes;
    infinite where the load does not move the edge.

    The load at which elements let an edge meet a node errs, by how the sizes around it differ. That
    shows in the unevenness of the first node behind it, not in that of others. At a mid-side node
    the correction is a share of its difference from the second one (`_OFF_MID_SIDE`). At a corner
    it is one share of its difference from the third one, and one of that from the nodes ahead
    (`_OFF_CORNER`); 0 where these are not known.

    Parameters
    ----------
    edge
        between two nodes of its `interface`
    last_node
        last node of the zone that ends at the edge: a mid-side node or a corner
    unevenness
        (3,) how unevenly the load moves the edge, by the nodes behind it: 0 where evenly; or (4,)
        with that by the nodes ahead
    """
    if not np.isfinite(unevenness).all():
        return math.inf
    first_unevenness, second_unevenness, third_unevenness, *unevenness_ahead = unevenness.tolist()
    if not _is_corner(edge.interface, last_node):
        return float(_OFF_MID_SIDE * (first_unevenness - second_unevenness))
    if not unevenness_ahead:
        return 0.0
    share_by_third, share_by_ahead = _OFF_CORNER
    return float(
        share_by_third * (first_unevenness - third_unevenness)
        + share_by_ahead * (first_unevenness - unevenness_ahead[0])
    )


def _shares_of_spacing(
    edge: Edge, last_node: int, unevenness: Array
) -> tuple[float, float, float, float]:
    """How uncertain the place of an edge is, over the distance of its two nodes, in four parts: by
    the kind of the last node of its zone (corner or mid-side); by how near x = 0 is; by its
    correction; and by how unevenly the load moves it, `unevenness` (3,) or (4,), 0 where evenly.
    The root of the sum of their squares counts, as they have nothing to do with each other.
    """
    # Constants fitted to many solutions: shares beyond a corner and beyond a mid-side node; the
    # others are factors. _MOST_CORRECTION: beyond it nothing is corrected.
    is_corner = _is_corner(edge.interface, last_node)
    share_at_nodes = _BEYOND_CORNER if is_corner else _BEYOND_MID_SIDE
    nodes_from_middle = max(abs(edge.place) / edge.spacing, 1.0)
    share_by_middle = _BY_NEAR_MIDDLE / nodes_from_middle**2
    correction = abs(_correction(edge, last_node, unevenness))
    share_by_correction = _BY_CORRECTION * min(correction, _MOST_CORRECTION)
    range_of_unevenness = max(unevenness.max(), 0.0) - min(unevenness.min(), 0.0)
    share_by_unevenness = _BY_UNEVENNESS * float(range_of_unevenness) ** 2
    return share_at_nodes, share_by_middle, share_by_correction, share_by_unevenness


def _share_by_late_start(unevenness: Array) -> float:
    """Uncertainty of the place of a stick edge that has just met its first sliding node, over the
    distance of both nodes, because this node may have begun to slide late. It does so at the start
    of slip, or where the edge has jumped. Less is left as the edge comes to the next node.

    The slip of that node then shows less than the way that the edge has come from it. The nodes
    behind the edge show the load between both nodes without that slip; the force to the Coulomb
    limit shows the way that is left. The least of the three values counts.

    Parameters
    ----------
    unevenness
        (3,) how unevenly the load moves the edge, by the nodes behind it: logarithm of the load
        that each shows over that of an even motion
    """
    return 1 - math.exp(-max(float(np.min(unevenness)), 0.0))


class StickZone(NamedTuple):
    """Left and right end of the permanent stick zone of a load cycle: by the nodes around each end,
    and by the loads at the turning points of slip.

    Attributes
    ----------
    place_at_last_stuck, place_at_first_sliding
        (2,) places of the edge when it meets the last node that sticks, and when it meets the first
        one that slips; NaN where these are not known
    places_by_load
        (2,) of the edge between these two, by `Edge.of_stick`; NaN where no load takes it from the
        one to the other
    uncertainty_by_load
        (2,) how far these may be from the true ones, by the mesh
    turn_times
        instants at which the stick zone is as small as this one, at the left and the right end: the
        turning points of slip
    """

    place_at_last_stuck: Array
    place_at_first_sliding: Array
    places_by_load: Array
    uncertainty_by_load: Array
    turn_times: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())

    def in_unit(self, length: float) -> StickZone:
        """The permanent stick zone with its places and their uncertainty times a length."""
        return self._replace(
            place_at_last_stuck=self.place_at_last_stuck * length,
            place_at_first_sliding=self.place_at_first_sliding * length,
            places_by_load=self.places_by_load * length,
            uncertainty_by_load=self.uncertainty_by_load * length,
        )

    def moved(self, ways: Array) -> StickZone:
        """The permanent stick zone with its left and its right end moved by `ways` (2,) along x."""
        return self._replace(
            place_at_last_stuck=self.place_at_last_stuck + ways,
            place_at_first_sliding=self.place_at_first_sliding + ways,
            places_by_load=self.places_by_load + ways,
        )

    def mirrored(self) -> StickZone:
        """The permanent stick zone with a left end that is the mirror image of the right one, as
        only the right half of the nodes was solved. Its attributes have an entry for each end, left
        and right: places by nodes and by loads, and the instants at the turning points of slip.
        """
        outward_signs = np.array([-1.0, 1.0])
        return StickZone(
            place_at_last_stuck=outward_signs * self.place_at_last_stuck[1],
            place_at_first_sliding=outward_signs * self.place_at_first_sliding[1],
            places_by_load=outward_signs * self.places_by_load[1],
            uncertainty_by_load=np.repeat(self.uncertainty_by_load[1], 2),
            turn_times=(self.turn_times[1], self.turn_times[1]),
        )

    def confine(self, edges: Array) -> Array:
        """Ends (2,) of the permanent stick zone: places by the loads where there are any. Elsewhere
        they are the given `edges` (2,) if between the two nodes, or else the middle between these.

        `edges` are those of the intersection of all stick zones of the cycle. One that is more than
        four node distances away is left as it is: the zone may creep at its ends.

        `place_at_last_stuck` and `place_at_first_sliding` (2,) are the places of each end when it
        meets the last node that sticks, and the first one that slides. `places_by_load` are NaN
        where no load locates an end.
        """
        middle_of_nodes = (self.place_at_last_stuck + self.place_at_first_sliding) / 2
        is_near = np.abs(edges - middle_of_nodes) <= _SAME_EDGE * self.spacing
        places_by_nodes = np.where(self.holds(edges), edges, middle_of_nodes)
        places_by_load_or_nodes = np.where(
            np.isfinite(self.places_by_load), self.places_by_load, places_by_nodes
        )
        return np.where(is_near, places_by_load_or_nodes, edges)

    def uncertainty(self, edges: Array, uncertainty_of_stick_edges: Array) -> Array:
        """Uncertainty (2,) of the ends `edges` (2,) of the permanent stick zone, by the mesh.

        Where the loads locate an end (`places_by_load`), it is by the loads. Elsewhere it is
        `uncertainty_of_stick_edges` (2,), that at single instants. An end that lies between its
        places at the two nodes around it (`holds`) is uncertain by its larger distance from them at
        most.
        """
        distance_from_nodes = np.maximum(
            np.abs(edges - self.place_at_last_stuck), np.abs(edges - self.place_at_first_sliding)
        )
        uncertainty_by_nodes = np.where(
            self.holds(edges),
            np.minimum(distance_from_nodes, uncertainty_of_stick_edges),
            uncertainty_of_stick_edges,
        )
        return np.where(
            edges == self.places_by_load, self.uncertainty_by_load, uncertainty_by_nodes
        )

    def holds(self, edges: Array) -> Mask:
        """Whether each of two edges lies between the places at the two nodes around that end of the
        zone, (2,).
        """
        farthest_distance = np.maximum(
            np.abs(edges - self.place_at_last_stuck), np.abs(edges - self.place_at_first_sliding)
        )
        return np.asarray(farthest_distance <= self.spacing)

    @property
    def spacing(self) -> Array:
        """(2,) distance of the edge's places at the two nodes around each end."""
        return np.abs(self.place_at_first_sliding - self.place_at_last_stuck)


NO_ZONE = StickZone(*np.full((4, 2), np.nan))


class Excess(NamedTuple):
    """Error of the friction work of a load cycle because edges of contact and stick move from node
    to node; scaled.

    Attributes
    ----------
    value
        work in excess of the true one, to be subtracted
    rms
        root mean square of that over all places of the edges between their nodes
    n_edges
        number of edges that it is of
    is_unplaced
        whether there is a permanent stick zone, and none of its edges could be located
    stick_zone
        the permanent stick zone
    """

    value: float
    rms: float
    n_edges: int
    is_unplaced: bool = False
    stick_zone: StickZone = NO_ZONE


def excess(problem: ContactProblem, contact_states: Sequence[InterfaceState]) -> Excess:
    """Error of the friction work of a load cycle because edges of stick and contact move from node
    to node: positive where the discrete solution dissipates too much; scaled.

    An edge counts if the elements around it are quadratic and of equal size; one of stick, if two
    nodes or more slide beyond it at its turning points; one of contact, if the stick edge on its
    side counts. Their number goes to `problem.work_counts[TAKEN_OFF]`, among counts of computing
    steps.

    Parameters
    ----------
    problem
        the contact problem that the states solve
    contact_states
        contact states of the cycle, from that at its start on

    Returns
    -------
    Excess
        Error of the work, its rms over all places of the edges between their nodes, number of edges
        that count, and the permanent stick zone. Zeros without shear, and where no single zone of
        three nodes or more sticks through the cycle.
    """
    no_excess = Excess(0.0, 0.0, 0)
    problem.work_counts.pop(TAKEN_OFF, None)
    if not problem.has_shear:
        return no_excess

    slip = np.stack([state.slip for state in contact_states])
    is_always_stuck = _sticks_all_along(contact_states, slip)
    nodes_of_stick_zone = np.flatnonzero(is_always_stuck)
    # _ZONE: three nodes, fewest of a zone
    if len(nodes_of_stick_zone) < _ZONE or np.diff(nodes_of_stick_zone).max() > 1:
        return no_excess

    # Excess work at the edges of stick and of contact, on the right and on the left.
    stick_edges: dict[int, _StickEdgeAtTurns] = {}  # by the side, 1 or -1
    works_at_contact_edges: list[_ExcessWork] = []
    for side in (1, -1):
        stick_edge = _stick_edge_at_turns(problem, contact_states, slip, is_always_stuck, side)
        if stick_edge is None:
            continue
        stick_edges[side] = stick_edge
        work_at_contact_edge = _excess_at_contact_edge(problem, contact_states, slip, side)
        if work_at_contact_edge is not None:
            works_at_contact_edges.append(work_at_contact_edge)

    works_at_stick_edges = [
        stick_edge_at_turns.excess for stick_edge_at_turns in stick_edges.values()
    ]
    works_at_edges = works_at_stick_edges + works_at_contact_edges
    problem.work_counts[TAKEN_OFF] = len(works_at_edges)
    # The two edges of a zone mostly stand alike in their elements, so their errors add up.
    rms_of_all = math.hypot(
        sum(work_at_edge.rms for work_at_edge in works_at_stick_edges),
        sum(work_at_edge.rms for work_at_edge in works_at_contact_edges),
    )
    return Excess(
        value=sum(work_at_edge.work for work_at_edge in works_at_edges),
        rms=rms_of_all,
        n_edges=len(works_at_edges),
        is_unplaced=not works_at_edges,
        stick_zone=_permanent_stick_zone(problem, is_always_stuck, stick_edges),
    )


def _sticks_all_along(states: Sequence[InterfaceState], slip: Array) -> Mask:
    """Whether each node sticks through a whole load cycle, (n,): it is closed all along, and the
    range of its slip is next to 0: 1e-6 of the largest at most. `slip` (k, n) is that of the nodes
    at the k contact `states` of the cycle.
    """
    slip_range = np.ptp(slip, axis=0)
    is_closed = np.stack([state.is_closed for state in states])
    largest_range = np.max(slip_range, where=is_closed.any(axis=0), initial=0.0)
    # _STUCK: share of the largest range of slip below which a node sticks
    return np.asarray(is_closed.all(axis=0) & (slip_range <= _STUCK * largest_range))


def _permanent_stick_zone(
    problem: ContactProblem, is_always_stuck: Mask, stick_edges: Mapping[int, _StickEdgeAtTurns]
) -> StickZone:
    """Left and right end of the permanent stick zone of a load cycle, scaled: places of each when
    it meets the nodes around it, and its place by the loads; NaN where these are not known.

    Parameters
    ----------
    problem
        the contact problem of the nodes
    is_always_stuck
        (n,) nodes that stick through the whole cycle
    stick_edges
        side, 1 for right and -1 for left -> the edge located by the loads, if it could be: its
        place, the uncertainty of that, and the instants at the turning points of slip
    """
    places_at_last_stuck = np.full(2, np.nan)
    places_at_first_sliding = np.full(2, np.nan)
    places_by_load = np.full(2, np.nan)
    uncertainty_by_load = np.full(2, np.nan)
    turn_times: list[tuple[float, ...]] = [(), ()]
    for column, side in enumerate((-1, 1)):
        last_stuck_node = int(np.flatnonzero(is_always_stuck)[-1 if side > 0 else 0])
        first_sliding_node = last_stuck_node + side
        if _has_equal_elements(problem, first_sliding_node):
            places_at_last_stuck[column] = place_when_met(problem.interface, last_stuck_node, side)
            places_at_first_sliding[column] = place_when_met(
                problem.interface, first_sliding_node, side
            )
        if side in stick_edges:
            places_by_load[column] = stick_edges[side].place
            uncertainty_by_load[column] = stick_edges[side].uncertainty
            turn_times[column] = stick_edges[side].turn_times
    return StickZone(
        places_at_last_stuck,
        places_at_first_sliding,
        places_by_load,
        uncertainty_by_load,
        (turn_times[0], turn_times[1]),
    )


class _ExcessWork(NamedTuple):
    """Friction work of a load cycle in excess of the true one by one edge between two nodes, and
    the rms of that over the edge's places between them; scaled.
    """

    work: float
    rms: float


class _StickEdgeAtTurns(NamedTuple):
    """An edge of permanent stick at the turning points of slip; scaled.

    Attributes
    ----------
    excess
        friction work of the cycle in excess of the true one, because the edge is between two nodes
    place
        x of the edge, the mean of both turning points
    uncertainty
        how far this may be from the true place, by the mesh
    turn_times
        instants at the turning points
    """

    excess: _ExcessWork
    place: float
    uncertainty: float
    turn_times: tuple[float, ...]

    @classmethod
    def mean_of(
        cls,
        edges_at_turns: Sequence[_EdgeAtTurn],
        excess: _ExcessWork,
        turn_times: tuple[float, ...],
    ) -> _StickEdgeAtTurns:
        """Edge of permanent stick at the mean place of the edges at both turning points, with their
        mean uncertainty.
        """
        n_turns = len(edges_at_turns)
        place = sum(edge.place for edge in edges_at_turns) / n_turns
        uncertainty = sum(edge.uncertainty for edge in edges_at_turns) / n_turns
        return cls(excess, place, uncertainty, turn_times)


def _stick_edge_at_turns(
    problem: ContactProblem,
    contact_states: Sequence[InterfaceState],
    slip: Array,
    is_always_stuck: Mask,
    side: int,
) -> _StickEdgeAtTurns | None:
    """The edge of permanent stick on one side of x = 0, from the two turning points of slip: its
    place between two nodes, the mean of both, and the excess friction work by that place, the sum
    of both. None where it cannot be located.

    On a mesh the edge moves from node to node. So the slip of the nodes follows chords of a smooth
    curve, which they exceed by a known function of the edge's place between two nodes. The excess
    work of a turning point is the sum over nodes of f p times that excess of slip. Locked-in shear
    brings a node beside the edge nearer to the Coulomb limit at one turning point, and takes it
    further away at the other. The forces to the limit at both are added, so that it drops out.

    # notation: f friction, p and q normal and shear force of a node

    Parameters
    ----------
    problem
        the contact problem that the states solve
    contact_states
        contact states of a load cycle, from that at its start on
    slip
        (k, n) slip of the nodes at these states, scaled
    is_always_stuck
        (n,) nodes that stick through the whole cycle
    side
        1 for the right edge, -1 for the left one
    """
    nodes_at_edge = _NodesAtEdge.of_zone(is_always_stuck, side)
    if not _has_equal_elements(problem, nodes_at_edge.first_sliding):
        return None
    turns = _TurnsOfNode.found(contact_states, slip, nodes_at_edge.first_sliding)
    if turns is None:
        return None

    forces_to_limit_of_both = turns.added_forces_to_limit(problem.friction)
    n_loads = len(contact_states[0].loads)

    def rates_of_states(node_states: States) -> Array:
        """Derivatives (4, n) by Q of slip, normal force, shear force and gap of the nodes, for
        given `node_states` (n,).
        """
        return nodal_values(problem.rates(node_states, n_loads)[1])

    excess_work = 0.0
    rms_of_excess = 0.0
    edges_at_turns: list[_EdgeAtTurn] = []
    for sense, state_at_turn in turns.states_by_sense.items():
        slip_beside_edge = SlipBesideEdge(
            sense, turns.slip_range, float(forces_to_limit_of_both[nodes_at_edge.last_stuck])
        )
        # Of the nodes at the turn, those that have only reached the Coulomb limit stick.
        sticks_at_turn = is_always_stuck & (state_at_turn.node_states != OPEN)
        node_states = np.where(sticks_at_turn, STICK, state_at_turn.node_states).astype(np.int8)
        edge_at_turn = _edge_at_turn(
            problem,
            nodes_at_edge,
            slip_beside_edge,
            node_states,
            forces_to_limit_of_both,
            rates_of_states,
        )
        if edge_at_turn is None:
            return None
        edges_at_turns.append(edge_at_turn)
        excess_at_turn = _excess_at_turn(
            nodes_at_edge,
            edge_at_turn.edge,
            node_states,
            problem.friction,
            state_at_turn.pressure,
            rates_of_states,
        )
        excess_work += excess_at_turn.work
        rms_of_excess += excess_at_turn.rms
    return _StickEdgeAtTurns.mean_of(
        edges_at_turns, _ExcessWork(excess_work, rms_of_excess), turns.times
    )


class _NodesAtEdge(NamedTuple):
    """Nodes at an edge of the permanent stick zone, on one side of x = 0.

    Attributes
    ----------
    side
        1 for the right edge, -1 for the left one
    last_stuck, first_sliding
        last node of the zone, and the next one outwards
    opposite_sliding
        first node beyond the opposite edge of the zone; it need not exist
    """

    side: int
    last_stuck: int
    first_sliding: int
    opposite_sliding: int

    @classmethod
    def of_zone(cls, is_always_stuck: Mask, side: int) -> _NodesAtEdge:
        """Nodes at the right (`side` 1) or left (-1) edge of the zone whose nodes `is_always_stuck`
        (n,) states.
        """
        leftmost_stuck, rightmost_stuck = np.flatnonzero(is_always_stuck)[[0, -1]].tolist()
        last_stuck = rightmost_stuck if side > 0 else leftmost_stuck
        opposite_stuck = leftmost_stuck if side > 0 else rightmost_stuck
        return cls(side, last_stuck, last_stuck + side, opposite_stuck - side)

    def number_beyond_edge(self, is_sliding: Mask) -> int:
        """Number of nodes that slide, of those from the first sliding one outwards; `is_sliding` is
        (n,) of all nodes.
        """
        slides_beyond_edge = (
            is_sliding[self.first_sliding :]
            if self.side > 0
            else is_sliding[: self.first_sliding + 1]
        )
        return int(np.count_nonzero(slides_beyond_edge))


class _TurnsOfNode(NamedTuple):
    """Turning points of the slip of one node in a load cycle.

    Attributes
    ----------
    states_by_sense
        sense of the slip that ends there, 1 and -1 -> the last contact state at the turning point
    times
        instants at both turning points
    slip_range
        slip of the node from one turning point to the other
    """

    states_by_sense: dict[int, InterfaceState]
    times: tuple[float, ...]
    slip_range: float

    @classmethod
    def found(
        cls, contact_states: Sequence[InterfaceState], slip: Array, node: int
    ) -> _TurnsOfNode | None:
        """Turning points of the slip (k, n) of a node at k `contact_states` of a cycle; None where
        it does not slide in both senses, or a long run has dropped the forces there.
        """
        slip_of_node = slip[:, node]
        slip_range = float(np.ptp(slip_of_node))
        senses = slip_sign(np.array([state.node_states[node] for state in contact_states]))
        states_by_sense: dict[int, InterfaceState] = {}
        times: list[float] = []
        for sense in (1, -1):
            # _TURNED: share of its range of slip within which a node has turned round
            is_at_turn = sense * slip_of_node >= (
                np.max(sense * slip_of_node) - _TURNED * slip_range
            )
            turning_steps = np.flatnonzero((senses == sense) & is_at_turn)
            if not len(turning_steps) or not contact_states[turning_steps[-1]].is_complete:
                return None
            states_by_sense[sense] = contact_states[turning_steps[-1]]
            times += [contact_states[step].time for step in turning_steps.tolist()]
        return cls(states_by_sense, tuple(times), slip_range)

    def added_forces_to_limit(self, friction: float) -> Array:
        """Forces (n,) of all nodes to the Coulomb limit, f p - s q (s the sense of slip), added up
        over both turning points; `friction` is f.
        """
        forces_to_limit = [
            force_to_limit(state.pressure, state.shear, sense, friction)
            for sense, state in self.states_by_sense.items()
        ]
        return np.asarray(np.sum(forces_to_limit, axis=0))


class _EdgeAtTurn(NamedTuple):
    """An edge of stick at one turning point of slip; scaled.

    Attributes
    ----------
    edge
        located by the load between two nodes
    place
        its x, corrected beyond mid-side nodes
    uncertainty
        how far this may be from the true place, by the mesh
    """

    edge: Edge
    place: float
    uncertainty: float


def _edge_at_turn(
    problem: ContactProblem,
    nodes_at_edge: _NodesAtEdge,
    slip_beside_edge: SlipBesideEdge,
    node_states: States,
    forces_to_limit: Array,
    rates_of_states: Callable[[States], Array],
) -> _EdgeAtTurn | None:
    """Edge of permanent stick at a turning point of slip, by the slip and the force to the Coulomb
    limit from one turning point to the other, and their derivatives by Q. None where no finite load
    takes it from node to node, and where a single node slides beyond it.

    Parameters
    ----------
    problem
        the contact problem, with its nodes and friction
    nodes_at_edge
        around the edge
    slip_beside_edge
        sense and range of the slip of the first sliding node; force of the last stuck one to the
        limit
    node_states
        (n,) open, stick or slip of all nodes
    forces_to_limit
        (n,) forces of all nodes to the Coulomb limit, added up over both turning points
    rates_of_states
        function from node states to the derivatives (4, n) by Q of slip, normal force, shear force
        and gap
    """
    # a single sliding node does not locate the edge; _ZONE: 3
    if (
        nodes_at_edge.number_beyond_edge(slip_sign(node_states) == slip_beside_edge.sense)
        < _ZONE - 1
    ):
        return None
    rates_by_q = rates_of_states(node_states)
    edge = Edge.of_stick(
        problem, nodes_at_edge.side, nodes_at_edge.last_stuck, slip_beside_edge, rates_by_q
    )
    if not edge.is_moved:  # no finite load takes it to the next node
        return None
    _, pressure_rates, shear_rates, _ = rates_by_q
    rates_to_limit = force_to_limit(
        pressure_rates, shear_rates, slip_beside_edge.sense, problem.friction
    )
    unevenness = _unevenness(edge, nodes_at_edge.last_stuck, forces_to_limit, rates_to_limit)
    # _AT_TURNS: factor on the uncertainty of single edges at turning points
    share_at_nodes, *other_shares = _shares_of_spacing(edge, nodes_at_edge.last_stuck, unevenness)
    uncertainty_share = _AT_TURNS * (share_at_nodes + math.hypot(*other_shares))
    return _EdgeAtTurn(
        edge,
        place=_place_put_right(edge, nodes_at_edge.last_stuck, unevenness),
        uncertainty=edge.spacing * min(uncertainty_share, 1.0),
    )


def _excess_at_turn(
    nodes_at_edge: _NodesAtEdge,
    stick_edge: Edge,
    node_states: States,
    friction: float,
    normal_forces: Array,
    rates_of_states: Callable[[States], Array],
) -> _ExcessWork:
    """Excess friction work at one turning point of slip, by the place of the stick edge between two
    nodes: change of the slip rates as the edge meets its node, and the opposite edge its own, times
    the excess at the place of the edge.

    Parameters
    ----------
    nodes_at_edge
        around the edge, and the first one beyond the opposite edge: it counts if it slides in the
        same sense
    stick_edge
        located by the load
    node_states
        (n,) open, stick or slip of all nodes
    friction
        coefficient f
    normal_forces
        (n,) nodal normal forces at the turning point
    rates_of_states
        function from node states to the derivatives (4, n) by Q of slip, normal force, shear force
        and gap
    """
    opposite_slides = 0 <= nodes_at_edge.opposite_sliding < len(node_states) and (
        node_states[nodes_at_edge.opposite_sliding] == node_states[nodes_at_edge.first_sliding]
    )
    changed_nodes = (
        (nodes_at_edge.first_sliding, nodes_at_edge.opposite_sliding)
        if opposite_slides
        else (nodes_at_edge.first_sliding,)
    )

    def slip_by_load(states_of_nodes: States) -> Array:
        """(n,) derivative of the nodal slip by Q, for given states of the nodes."""
        return np.asarray(rates_of_states(states_of_nodes)[0])

    change_of_slip_rates = _change_of_rates(slip_by_load, node_states, changed_nodes, STICK)
    work_by_load = friction * float(normal_forces @ change_of_slip_rates)
    # `load_over_rate_jump`: load between the nodes over the dimensionless change of rates;
    # `fraction_passed`: way of the edge from its node to its place, over that to the next node
    work_of_unit_excess = work_by_load * stick_edge.load_over_rate_jump
    excess_at_place = float(stick_edge.dimensionless_excess(stick_edge.fraction_passed()))
    # _RMS: root mean square of the dimensionless excess over all places of an edge
    return _ExcessWork(-work_of_unit_excess * excess_at_place, abs(work_of_unit_excess) * _RMS)


def _excess_at_contact_edge(
    problem: ContactProblem, contact_states: Sequence[InterfaceState], slip: Array, side: int
) -> _ExcessWork | None:
    """Excess friction work of a load cycle by the place of the contact edge between two nodes, on
    one side of x = 0; None where the edge cannot be located at some increment in which nodes slip.

    Along each increment the pressure is linear in P, and no node touches or separates. So, as the
    edge goes from node to node, the pressure follows chords of a smooth curve, which they exceed by
    a known function of the edge's place between two nodes. The excess work of an increment is the
    sum over nodes of f |slip| times that excess of pressure, integrated over the increment.

    # notation: f coefficient of friction

    Parameters
    ----------
    problem
        the contact problem that the states solve; its `rates` are derivatives of nodal values by
        the loads at given node states, its `interface.coupling` is None of like bodies
    contact_states
        contact states of a load cycle, from that at its start on
    slip
        (k, n) slip of the nodes at these states, scaled
    side
        1 for the right edge, -1 for the left one
    """
    rates_by_p = _RatesByNormalLoad(problem, len(contact_states[0].loads), {})
    for state in contact_states:
        rates_by_p.by_load(state.node_states)  # cached in the order of the states
    excess_work = 0.0
    unit_works_at_nodes: dict[int, float] = {}  # by the node inside the edge
    slip_sizes_of_increments = np.abs(np.diff(slip, axis=0))
    for start_state, end_state, slip_sizes in zip(
        contact_states[:-1], contact_states[1:], slip_sizes_of_increments, strict=True
    ):
        if not slip_sizes.any():
            continue
        contact_edge = _contact_edge_at(rates_by_p, start_state, side)
        if contact_edge is None:
            return None
        work_of_unit_excess = _work_of_unit_excess(
            rates_by_p, contact_edge, start_state, slip_sizes
        )
        # Places of the edge in the increment: fractions of the way from node to node that it has
        # passed at start, middle and end.
        fraction_at_start = contact_edge.fraction_passed()
        fraction_at_end = contact_edge.fraction_passed(end_state.loads[0] - start_state.loads[0])
        fraction_in_middle = (fraction_at_start + fraction_at_end) / 2
        fractions = [fraction_at_start, fraction_in_middle, fraction_at_end]
        # Simpson's rule along the increment
        excess_work -= (
            work_of_unit_excess
            * float(contact_edge.dimensionless_excess(fractions) @ [1, 4, 1])
            / 6
        )
        unit_works_at_nodes[contact_edge.node] = unit_works_at_nodes.get(
            contact_edge.node, 0.0
        ) + abs(work_of_unit_excess)
    # All along from node to node the excess has mean zero. What counts is the place at which the
    # edge stays while most slip happens.
    # _RMS: root mean square of the dimensionless excess over all places of an edge
    return _ExcessWork(excess_work, max(unit_works_at_nodes.values(), default=0.0) * _RMS)


class _RatesByNormalLoad(NamedTuple):
    """Derivatives of the nodal values by P for sets of node states, cached; scaled.

    Attributes
    ----------
    problem
        the contact problem; its `interface.coupling` is None of like bodies
    n_loads
        number of loads of the path: 2, or 5 with bulk stress or tilt
    rates_of_contacts
        derivatives (4, n) by the set of closed nodes, as they are found
    """

    problem: ContactProblem
    n_loads: int
    rates_of_contacts: dict[bytes, Array]

    def by_load(self, node_states: States) -> Array:
        """Derivatives (4, n) by P of slip, normal force, shear force and gap of the nodes, for
        given `node_states` (n,). Between like bodies they depend on the closed nodes alone; unlike
        ones are taken in full stick.
        """
        if self.problem.interface.coupling is not None:
            node_states = np.where(node_states != OPEN, STICK, OPEN).astype(np.int8)
        closed_key = (node_states != OPEN).tobytes()
        if closed_key not in self.rates_of_contacts:
            self.rates_of_contacts[closed_key] = nodal_values(
                self.problem.rates(node_states, self.n_loads)[0]
            )
        return self.rates_of_contacts[closed_key]

    def pressure_by_load(self, node_states: States) -> Array:
        """(n,) derivative of the nodal normal force by P, for given `node_states` (n,)."""
        return np.asarray(self.by_load(node_states)[1])


def _contact_edge_at(
    rates_by_p: _RatesByNormalLoad, state: InterfaceState, side: int
) -> Edge | None:
    """Edge of contact at an instant, on the right (`side` 1) or left (-1) of x = 0, located by P
    between the outermost closed node and the next one.

    None where no finite load takes it to the next node, where there is none, where the elements
    around the node are not quadratic and of equal size, and where a long run has dropped the
    forces. `rates_by_p` has the derivatives by P, `state` nodal forces and gaps.
    """
    closed_nodes = np.flatnonzero(state.is_closed)
    outermost_node = int(closed_nodes[-1 if side > 0 else 0])
    if not state.is_complete or not _has_equal_elements(rates_by_p.problem, outermost_node):
        return None
    if not 0 <= outermost_node + side < len(state.node_states):
        return None
    contact_edge = Edge.of_contact(
        rates_by_p.problem, side, outermost_node, state, rates_by_p.by_load(state.node_states)
    )
    return contact_edge if contact_edge.is_moved else None


def _work_of_unit_excess(
    rates_by_p: _RatesByNormalLoad,
    contact_edge: Edge,
    start_state: InterfaceState,
    slip_sizes: Array,
) -> float:
    """Friction work of an increment by a unit of the dimensionless excess of pressure: f |slip|
    times the change of the pressure rates as the contact edge meets its node, and the opposite edge
    its own; scaled.

    Parameters
    ----------
    rates_by_p
        derivatives of the nodal values by P
    contact_edge
        located by P at the start of the increment
    start_state
        contact state at the start of the increment
    slip_sizes
        (n,) |slip| of the nodes in the increment
    """
    problem = rates_by_p.problem
    opposite_node = int(np.flatnonzero(start_state.is_closed)[0 if contact_edge.side > 0 else -1])
    changing_nodes = (
        (contact_edge.node, opposite_node)
        if _has_equal_elements(problem, opposite_node)
        else (contact_edge.node,)
    )
    change_of_pressure_rates = _change_of_rates(
        rates_by_p.pressure_by_load, start_state.node_states, changing_nodes, OPEN
    )
    work_by_load = problem.friction * float(slip_sizes @ change_of_pressure_rates)
    # `load_over_rate_jump`: load between the nodes over the dimensionless change of rates
    return work_by_load * contact_edge.load_over_rate_jump


def _load_to(distance: float, rate: float) -> float:
    """Change of load by which a nodal force, gap or slip changes by a `distance`, at its derivative
    by the load; infinite where the load does not change it.
    """
    return float(distance) / abs(float(rate)) if rate else math.inf


def _change_of_rates(
    rates_of_states: Callable[[States], Array],
    node_states: States,
    changed_nodes: tuple[int, ...],
    earlier_state: int,
) -> Array:
    """Change (n,) of the derivatives of a nodal quantity by the load, when a node touches or starts
    to slide.

    Two nodes may have done so at once, one at each edge: the mean over both orders.

    Parameters
    ----------
    rates_of_states
        function from the states of the nodes (n,) to the derivatives (n,)
    node_states
        (n,) open, stick or slip of the nodes, after the change
    changed_nodes
        the node that changed, and if there is one, the other that did so with it
    earlier_state
        state of these nodes before the change: open or stick
    """
    node, *second_node = changed_nodes
    changes = []
    # the second node changes before the first one, or after it
    for later_nodes in {(), tuple(second_node)}:
        node_states_after = node_states.copy()
        node_states_after[list(later_nodes)] = earlier_state
        node_states_before = node_states_after.copy()
        node_states_before[node] = earlier_state
        changes.append(rates_of_states(node_states_after) - rates_of_states(node_states_before))
    return np.asarray(sum(changes) / len(changes))


def _has_equal_elements(problem: ContactProblem, node: int) -> bool:
    """Whether a node and its two neighbours on either side have quadratic elements of equal size
    around them.

    By Simpson's rule a mid-side node then stands for twice the length of face of its neighbours,
    which are corners of two elements: 1.8 to 2.2 times (`_SIMPSON`).
    """
    lengths = problem.interface.face_lengths
    if not 2 <= node < len(lengths) - 2:
        return False
    # The node and those two nodes away are of one kind, its neighbours of the other kind.
    lengths_of_own_kind = lengths[node - 2 : node + 3 : 2].tolist()
    lengths_beside = lengths[node - 1 : node + 2 : 2].tolist()
    corner_lengths, mid_side_lengths = sorted((lengths_of_own_kind, lengths_beside), key=max)
    least_ratio, largest_ratio = _SIMPSON
    if min(mid_side_lengths) < least_ratio * max(corner_lengths):
        return False
    return max(mid_side_lengths) <= largest_ratio * min(corner_lengths)
