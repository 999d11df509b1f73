r"""Edges between nodes: where the edge of permanent stick stands between two nodes, and what W of a
revolution has in excess because edges of contact and stick go from node to node.

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
An edge meets a corner node 0.042 elements before it is there, on its way outwards, and a mid-side
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

from halfplane_fe.contact import ContactProblem, InterfaceState, nodal
from halfplane_fe.interface import Interface
from halfplane_fe.law import force_to_limit, slip_sign
from scenes import OPEN, STICK
from scenes.array_types import Array, Indices, Mask, States

# D and V, and the distance of an edge from a corner node outwards when it meets that, in elements:
# least squares on Hertz' compression pressed through 40 elements.
_D = 0.566
_V = 0.0335
_CORNER_IS_MET = 0.042
_V_OF_BOTH = (_D**3 + (1 - _D) ** 3) / 6
_JUMP_OF_MIDDLE = 0.5 + _V * (1 / _D + 1 / (1 - _D))
# rms of g over the edge's places.
_RMS = 0.0155
# Share of the distance of two nodes by which an edge of permanent stick between them, placed by the
# loads, is uncertain: 0.02 rms on 159 random half-planes, seeds 301 to 303, both presets. Twice as
# much of a zone that is eight such distances wide.
_PLACED = 0.06
_NARROW = 8.0
# Shares of that distance by which a stick edge on its way is uncertain: one always; one over the
# nodes that it has passed since slip began; one by how unevenly the load takes it on. It errs by
# 0.015 in the median. Random half-planes, seeds 301, 302 and 310.
_ON_ITS_WAY = 0.025
_BESIDE_ITS_START = 0.08
_BY_UNEVENNESS = 0.3
# The same of contact edges, three times as large where one node touches on each side: 0.02 in the
# median between half-planes, 0.1 at most; of cylinders 0.08.
_CONTACT = 0.09
# Closed nodes on its side of x = 0 below which no load places a contact edge.
_CLOSED = 6
# What both are less certain by between elements of several sizes.
_OF_SEVERAL_SIZES = 0.05
# Places of the stuck nodes that show that, behind the last one, whose force is the mesh's own,
_BEHIND = np.array([1, 2, 3])
# and nodes that must stick.
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
    """An edge of contact or of stick between two nodes, by the load that has taken it there.

    Forces, gap and slip of both nodes place it to a fiftieth of their distance. Which of them slips
    or touches places it to half of that. It takes the rates by the load, which only states of the
    run have. An increment has no sides: it lands on the first of all nodes
    (`stepping.next_event`).

    Attributes
    ----------
    interface
        whose nodes they are
    side
        1 on the right of x = 0, -1 on the left
    node, next_node
        which it met last, and which it meets next
    load_from_node, load
        that has taken it from the one node to where it is, and that takes it to the other
    """

    interface: Interface
    side: int
    node: int
    next_node: int
    load_from_node: float
    load: float

    @classmethod
    def of_contact(
        cls, problem: ContactProblem, side: int, node: int, state: InterfaceState, by_load: Array
    ) -> Edge:
        """The edge of contact beyond a closed node, by its pressure and the gap of the next one.

        `by_load` (4, n) are the rates of slip, pressure, shear and gap by P.
        """
        next_node = node + side
        _, pressure_rates, _, gap_rates = by_load
        load_from_node = _load_to(state.pressure[node], pressure_rates[node])
        load_to_next = _load_to(state.gap[next_node], gap_rates[next_node])
        load = load_from_node + load_to_next
        return cls(problem.interface, side, node, next_node, load_from_node, load)

    @classmethod
    def of_stick(
        cls, problem: ContactProblem, side: int, last_stuck: int, turn: TurnOfSlip, by_load: Array
    ) -> Edge:
        """The edge of stick on its way inwards from the first sliding node, by its slip and what
        the shear of the last stuck one lacks of the Coulomb limit.

        Both are counted from one turn of the slip to the other, so that locked-in shear drops out.
        Between the turns it counts: beside an older edge of stick such a place is wrong by up to
        the distance of the nodes. `by_load` (4, n) are the rates of slip, pressure, shear and gap
        by Q.
        """
        node = last_stuck + side
        slip_rates, pressure_rates, shear_rates, _ = by_load
        force_rates = force_to_limit(pressure_rates, shear_rates, turn.sense, problem.friction)
        load_from_node = _load_to(turn.slip, slip_rates[node])
        load = load_from_node + _load_to(turn.force_to_limit, force_rates[last_stuck])
        return cls(problem.interface, side, node, last_stuck, load_from_node, load)

    @property
    def is_moved(self) -> bool:
        """Whether the load takes it from the one node to the other."""
        return 0 < self.load < math.inf

    def share(self, change_of_load: float = 0.0) -> float:
        """Of the way from the one node to the other: where the edge is after a change of load."""
        return float(np.clip(self.load_from_node + change_of_load, 0.0, self.load) / self.load)

    @property
    def place(self) -> float:
        """Where it is, over the half-width."""
        place_at_node, place_at_next = self._ends
        return place_at_node + self.share() * (place_at_next - place_at_node)

    @property
    def spacing(self) -> float:
        """From where it meets the one node to where it meets the other, over the half-width."""
        place_at_node, place_at_next = self._ends
        return abs(place_at_next - place_at_node)

    @property
    def _ends(self) -> tuple[float, float]:
        """Where it meets the one node and the other."""
        return (
            place_when_met(self.interface, self.node, self.side),
            place_when_met(self.interface, self.next_node, self.side),
        )

    def excess_per_work(self, share: ArrayLike) -> Array:
        """g of the module, the dimensionless work in excess, at a share of the way."""
        at_corner = (_V_OF_BOTH - _V) / 2
        at_middle = (_V_OF_BOTH + _V) / 2
        v_of_node, v_of_next = (
            (at_corner, at_middle) if self._is_at_corner else (at_middle, at_corner)
        )
        t = np.asarray(share)
        return np.asarray(v_of_node + (v_of_next - v_of_node) * t - self._way**2 * t * (1 - t) / 2)

    @property
    def load_per_jump(self) -> float:
        """Load over the jump of the rates at the node, which makes work of g."""
        jump_of_node = 1 - _JUMP_OF_MIDDLE if self._is_at_corner else _JUMP_OF_MIDDLE
        return self.load / (self._way * jump_of_node)

    @property
    def _is_at_corner(self) -> bool:
        return _is_corner(self.interface, self.node)

    @property
    def _way(self) -> float:
        """d of the module, in elements."""
        is_inwards = (self.next_node - self.node) * self.side < 0
        return _D if self._is_at_corner == is_inwards else 1 - _D


class TurnOfSlip(NamedTuple):
    """How far slip beside an edge of stick has come, or where it turns round.

    Attributes
    ----------
    sense
        of the slip, 1 or -1
    slip
        of the first sliding node since it began, or from one turn to the other
    force_to_limit
        f p - s q of the last stuck node, or the sum of both turns
    """

    sense: int
    slip: float
    force_to_limit: float


def place_when_met(interface: Interface, node: int, side: int) -> float:
    """Place of an edge on one side of x = 0, 1 or -1, when it meets a node."""
    x = interface.x
    before_node = _CORNER_IS_MET if _is_corner(interface, node) else _CORNER_IS_MET + _D - 0.5
    return float(x[node] - side * before_node * abs(x[node + 1] - x[node - 1]))


def _is_corner(interface: Interface, node: int) -> bool:
    """Whether a node of quadratic elements is a corner, not a mid-side one."""
    return bool(interface.weights[node] < interface.weights[node - 1])


class EdgesByLoad(NamedTuple):
    """Edges of contact or of stick of k instants by the load that moves them, left and right.

    Attributes
    ----------
    last_node
        (k, 2) last node that touches, or sticks; -1 where no load places an edge
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
        """No edge at any instant."""
        shape = (n_instants, 2)
        return cls(np.full(shape, -1), np.full(shape, np.nan), np.full(shape, np.nan))

    @classmethod
    def joined(cls, parts: Sequence[EdgesByLoad]) -> EdgesByLoad:
        """Those of instants that follow each other."""
        return cls(*(np.concatenate(values) for values in zip(*parts, strict=True)))

    def at(self, rows: Indices | slice) -> EdgesByLoad:
        """Those of some instants."""
        return EdgesByLoad(self.last_node[rows], self.places[rows], self.uncertainty[rows])

    def mirrored(self, middle: int) -> EdgesByLoad:
        """Both edges by the right one of a half, whose first node is number `middle` of all."""
        right_node = self.last_node[:, 1:]
        outwards = np.array([-1, 1])
        return EdgesByLoad(
            last_node=np.where(right_node < 0, -1, middle + outwards * right_node),
            places=outwards * self.places[:, 1:],
            uncertainty=np.repeat(self.uncertainty[:, 1:], 2, axis=1),
        )

    def put(self, row: int, last_node: int, edge: Edge, share: float) -> None:
        """Store the edge beyond a node, uncertain by a share of the distance of two nodes."""
        column = 0 if edge.side < 0 else 1
        self.last_node[row, column] = last_node
        self.places[row, column] = edge.place
        self.uncertainty[row, column] = edge.spacing * min(share, 1.0)


def contact_by_load(problem: ContactProblem, states: Sequence[InterfaceState]) -> EdgesByLoad:
    """Edges of contact of k states by P."""
    edges = EdgesByLoad.nowhere(len(states))
    for row, state in enumerate(states):
        if not state.normal_load > 0:
            continue
        by_load = None
        for side in (-1, 1):
            inwards = _inwards(problem, state, side)
            share = (
                _share_of_elements(problem, int(inwards[0])) if len(inwards) >= _CLOSED else None
            )
            if share is None:
                continue
            if by_load is None:
                by_load = nodal(problem.rates(state.state, len(state.loads))[0])
            edge = Edge.of_contact(problem, side, int(inwards[0]), state, by_load)
            if edge.is_moved:
                edges.put(row, edge.node, edge, _CONTACT * (1 + 2 / len(inwards)) + share)
    return edges


def stick_by_load(
    problem: ContactProblem, states: Sequence[InterfaceState], travels: Array
) -> EdgesByLoad:
    """Stick edges of k states that a load takes inwards, by that load.

    `travels` (k, n) is what each node has slipped since it last stuck or turned round.
    """
    edges = EdgesByLoad.nowhere(len(states))
    if not problem.tangential:
        return edges
    for row, (state, travel) in enumerate(zip(states, travels, strict=True)):
        for side in (-1, 1):
            last_stuck, n_passed = _behind_slip_zone(problem, state, travel, side)
            share = _share_of_elements(problem, last_stuck + side) if n_passed else None
            if share is None:
                continue
            edge, unevenness = _placed_by_load(problem, state, travel, side, last_stuck)
            if edge.is_moved:
                share += _ON_ITS_WAY + _BESIDE_ITS_START / n_passed + _BY_UNEVENNESS * unevenness
                edges.put(row, last_stuck, edge, share)
    return edges


def _share_of_elements(problem: ContactProblem, node: int) -> float | None:
    """Share of the distance of two nodes by which an edge beside a node is uncertain for elements
    of several sizes; None where there are no quadratic elements.
    """
    if not 2 <= node < len(problem.interface.weights) - 2:
        return None
    if _regular(problem, node):
        return 0.0
    kinds = {_is_corner(problem.interface, beside) for beside in (node - 1, node + 1)}
    alternates = kinds == {not _is_corner(problem.interface, node)}
    return _OF_SEVERAL_SIZES if alternates else None


def _inwards(problem: ContactProblem, state: InterfaceState, side: int) -> Indices:
    """Closed nodes on one side of x = 0, from the outermost one inwards."""
    is_on_side = state.closed & (side * problem.interface.x >= 0)
    return np.flatnonzero(is_on_side)[::-side]


def _behind_slip_zone(
    problem: ContactProblem, state: InterfaceState, travel: Array, side: int
) -> tuple[int, int]:
    """The last node that sticks behind the outermost slip zone on one side of x = 0, and how many
    nodes the edge has passed since slip began: none where too few stick.

    Slip began beside the node that has come farthest. `travel` (n,) is how far each has.
    """
    inwards = _inwards(problem, state, side)
    slides = slip_sign(state.state[inwards]) != 0
    if not slides.any():
        return -1, 0
    outermost = int(np.argmax(slides))  # nodes that have just come to touch stick
    first_stuck = outermost + int(np.argmin(slides[outermost:]))
    stick_zone = slice(first_stuck, first_stuck + _STICK_ZONE)
    if len(inwards[stick_zone]) < _STICK_ZONE or slides[stick_zone].any():
        return -1, 0
    farthest = outermost + int(np.argmax(np.abs(travel[inwards[outermost:first_stuck]])))
    return int(inwards[first_stuck]), first_stuck - farthest


def _placed_by_load(
    problem: ContactProblem, state: InterfaceState, travel: Array, side: int, last_stuck: int
) -> tuple[Edge, float]:
    """The stick edge that slip takes inwards to the node `last_stuck`, and how unevenly a load
    takes it on: 0 where it does so evenly.

    Behind the edge f p - s q grows as the root of the distance d, and its rate falls as that. Over
    its rate it is twice the load that takes the edge on by d, wherever the load does so evenly.
    Beside an older stick edge or a kink of the profile it does not. The logarithm of the ratio of
    both tells, the largest of some nodes.
    """
    node = last_stuck + side
    sense = int(slip_sign(state.state[node]))
    by_load = nodal(problem.rates(state.state, len(state.loads))[1])
    _, pressure_rates, shear_rates, _ = by_load
    to_limit = force_to_limit(state.pressure, state.shear, sense, problem.friction)
    rates_to_limit = force_to_limit(pressure_rates, shear_rates, sense, problem.friction)
    turn = TurnOfSlip(sense, sense * float(travel[node]), float(to_limit[last_stuck]))
    edge = Edge.of_stick(problem, side, last_stuck, turn, by_load)
    if not edge.is_moved:
        return edge, math.inf
    behind = last_stuck - side * _BEHIND
    loads = np.maximum(to_limit[behind], 0.0) / np.abs(rates_to_limit[behind])
    distances = np.abs(problem.interface.x[behind] - edge.place)
    even_loads = 2 * edge.load * distances / edge.spacing
    ratios = np.maximum(loads / even_loads, _LEAST_SHARE)
    return edge, float(np.max(np.abs(np.log(ratios))))


class StickZone(NamedTuple):
    """Where what sticks through a revolution ends, left and right, by its nodes and by the loads at
    the turns of slip.

    Attributes
    ----------
    last_node, first_node
        (2,) places of the edge when it meets the last node that sticks, and when it meets the first
        one that slips; NaN where these are not known
    places
        (2,) of the edge between them by the loads; NaN where no load takes it from the one to the
        other
    turns
        instants, left and right, at which the stick zone is this one: the turns of slip
    """

    last_node: Array
    first_node: Array
    places: Array
    turns: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())

    def in_unit(self, length: float) -> StickZone:
        """The zone with its places times a length."""
        return self._replace(
            last_node=self.last_node * length,
            first_node=self.first_node * length,
            places=self.places * length,
        )

    def mirrored(self) -> StickZone:
        """The zone with a left end that is the image of the right one."""
        outwards = np.array([-1.0, 1.0])
        return StickZone(
            last_node=outwards * self.last_node[1],
            first_node=outwards * self.first_node[1],
            places=outwards * self.places[1],
            turns=(self.turns[1], self.turns[1]),
        )

    def confine(self, edges: Array) -> Array:
        """(2,) the places by the loads; without one the edge by the stick zones of the instants,
        where it lies between the two nodes, or else the middle between them.

        Edges more than some nodes away are none of this zone, which may creep at its rim.
        """
        middle = (self.last_node + self.first_node) / 2
        is_same = np.abs(edges - middle) <= _SAME_EDGE * self.spacing
        at_nodes = np.where(self.holds(edges), edges, middle)
        by_nodes = np.where(np.isfinite(self.places), self.places, at_nodes)
        return np.where(is_same, by_nodes, edges)

    def uncertainty(self, edges: Array, by_stick_zones: Array) -> Array:
        """(2,) of the confined edges: by the stick zones of the instants, but no more than what the
        two nodes leave open, and a share of their distance where the loads place the edge.
        """
        by_nodes = np.maximum(np.abs(edges - self.last_node), np.abs(edges - self.first_node))
        confined = np.where(self.holds(edges), np.minimum(by_nodes, by_stick_zones), by_stick_zones)
        is_narrow = (_NARROW * self.spacing / (edges[1] - edges[0])) ** 2
        placed = _PLACED * (1 + is_narrow) * self.spacing
        return np.where(edges == self.places, placed, confined)

    def holds(self, edges: Array) -> Mask:
        """(2,) whether an edge lies between its two nodes."""
        farthest = np.maximum(np.abs(edges - self.last_node), np.abs(edges - self.first_node))
        return np.asarray(farthest <= self.spacing)

    @property
    def spacing(self) -> Array:
        """(2,) from the one place to the other."""
        return np.abs(self.first_node - self.last_node)


NO_ZONE = StickZone(np.full(2, np.nan), np.full(2, np.nan), np.full(2, np.nan))


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
    stick_zone
        what sticks all along
    """

    value: float
    scatter: float
    edges: int
    is_unplaced: bool = False
    stick_zone: StickZone = NO_ZONE


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
    at_stick_edges: dict[int, _AtTurns] = {}
    at_contact_edges: list[_EdgeWork] = []
    for side in (1, -1):
        at_stick_edge = _at_stick_edge(problem, states, slip, sticks_all_along, side)
        if at_stick_edge is None:
            continue
        at_stick_edges[side] = at_stick_edge
        at_contact_edge = _at_contact_edge(problem, states, slip, side)
        if at_contact_edge is not None:
            at_contact_edges.append(at_contact_edge)
    all_edges = [*(edge.work for edge in at_stick_edges.values()), *at_contact_edges]
    problem.work[TAKEN_OFF] = len(all_edges)
    # the two edges of a zone mostly stand alike in their elements: their scatters add up
    scatter_of_all = math.hypot(
        sum(edge.work.scatter for edge in at_stick_edges.values()),
        sum(edge.scatter for edge in at_contact_edges),
    )
    return Excess(
        value=sum(edge.work for edge in all_edges),
        scatter=scatter_of_all,
        edges=len(all_edges),
        is_unplaced=not all_edges,
        stick_zone=_stick_zone(problem, sticks_all_along, at_stick_edges),
    )


def _stick_zone(
    problem: ContactProblem, sticks: Mask, at_stick_edges: Mapping[int, _AtTurns]
) -> StickZone:
    """Ends of the nodes (n,) that stick through a revolution, with what is known at its turns by
    the side, 1 or -1.
    """
    last_node = np.full(2, np.nan)
    first_node = np.full(2, np.nan)
    places = np.full(2, np.nan)
    turns: list[tuple[float, ...]] = [(), ()]
    for column, side in enumerate((-1, 1)):
        last_stuck = int(np.flatnonzero(sticks)[-1 if side > 0 else 0])
        if _regular(problem, last_stuck + side):
            last_node[column] = place_when_met(problem.interface, last_stuck, side)
            first_node[column] = place_when_met(problem.interface, last_stuck + side, side)
        if side in at_stick_edges:
            places[column] = at_stick_edges[side].place
            turns[column] = at_stick_edges[side].turns
    return StickZone(last_node, first_node, places, (turns[0], turns[1]))


class _EdgeWork(NamedTuple):
    """Work in excess at an edge, and its rms over where the edge stands."""

    work: float
    scatter: float


class _AtTurns(NamedTuple):
    """An edge of permanent stick at the turns of slip: its work in excess, its place, and the
    instants of the turns.
    """

    work: _EdgeWork
    place: float
    turns: tuple[float, ...]


def _at_stick_edge(
    problem: ContactProblem,
    states: Sequence[InterfaceState],
    slip: Array,
    sticks: Mask,
    side: int,
) -> _AtTurns | None:
    """The edge of permanent stick on one side of x = 0 at the turns of slip: its place between two
    nodes, and the work in excess by that; None where it does not count.

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
    turns: list[float] = []
    for sign in (1, -1):
        is_at_turn = sign * slip_of_node >= np.max(sign * slip_of_node) - _TURNED * slip_range
        turning_numbers = np.flatnonzero((signs == sign) & is_at_turn)
        if not len(turning_numbers) or not states[turning_numbers[-1]].is_complete:
            return None
        states_at_turns[sign] = states[turning_numbers[-1]]
        turns += [states[number].time for number in turning_numbers.tolist()]
    friction = problem.friction
    distance_to_limit = sum(
        float(force_to_limit(state.pressure[last_stuck], state.shear[last_stuck], sign, friction))
        for sign, state in states_at_turns.items()
    )
    work_in_excess = 0.0
    scatter = 0.0
    places: list[float] = []
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
        turn = TurnOfSlip(sign, slip_range, distance_to_limit)
        by_load = nodal(problem.rates(states_at_turn, n_loads)[1])
        edge = Edge.of_stick(problem, side, last_stuck, turn, by_load)
        if not edge.is_moved:
            return None
        places.append(edge.place)
        opposite_slides = 0 <= opposite_node < len(is_sliding) and bool(is_sliding[opposite_node])
        nodes = (node, opposite_node) if opposite_slides else (node,)

        def slip_by_load(states: States) -> Array:
            return np.asarray(nodal(problem.rates(states, n_loads)[1])[0])

        slip_jump = _jump(slip_by_load, states_at_turn, nodes, STICK)
        work_of_jump = problem.friction * float(turning_state.pressure @ slip_jump)
        edge_work = work_of_jump * edge.load_per_jump
        work_in_excess -= edge_work * float(edge.excess_per_work(edge.share()))
        scatter += abs(edge_work) * _RMS
    return _AtTurns(
        work=_EdgeWork(work_in_excess, scatter),
        place=sum(places) / len(places),
        turns=tuple(turns),
    )


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
        edge = Edge.of_contact(problem, side, node, start, rates_by_load(start.state))
        if not edge.is_moved:
            return None
        share_at_start = edge.share()
        share_at_end = edge.share(end.loads[0] - start.loads[0])
        shares = [share_at_start, (share_at_start + share_at_end) / 2, share_at_end]
        nodes = (node, opposite_node) if _regular(problem, opposite_node) else (node,)
        pressure_jump = _jump(pressure_by_load, start.state, nodes, OPEN)
        work_of_jump = problem.friction * float(node_slips @ pressure_jump)
        edge_work = work_of_jump * edge.load_per_jump
        # Simpson's rule along the increment
        work_in_excess -= edge_work * float(edge.excess_per_work(shares) @ [1, 4, 1]) / 6
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
