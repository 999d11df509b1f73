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

from halfplane_fe.arrays import Array, Mask, States
from halfplane_fe.contact import ContactProblem, InterfaceState, nodal
from halfplane_fe.law import slip_sign
from scenes import OPEN, STICK

# D and V: least squares on Hertz' compression pressed through 40 elements. rms of g over the edge's
# places.
_WAY, _APART, _RMS = 0.566, 0.0335, 0.0155
# Weight of a mid-side node over that of its neighbours, in elements of one size: 2, from one size
# to the next more or less.
_SIMPSON = (1.8, 2.2)
# Slip of a node over the largest of the revolution below which it sticks; share of its own within
# which it has turned round.
_STUCK, _TURNED = 1e-6, 1e-6
# Nodes of a zone below which its edge is not far from another one.
_ZONE = 3


class Excess(NamedTuple):
    """Of the dissipation of a revolution, scaled.

    Attributes
    ----------
    value : what the edges that stand between nodes add to it
    scatter : rms of that over where they stand
    edges : how many there are
    """

    value: float
    scatter: float
    edges: int


def excess(problem: ContactProblem, states: Sequence[InterfaceState]) -> Excess:
    """What edges between nodes add to the dissipation of a revolution with these states, the one
    before it the first.

    An edge counts if its zones have three nodes or more, and if the elements around it are
    quadratic and of one size.
    """
    nothing = Excess(0.0, 0.0, 0)
    if not problem.tangential:
        return nothing
    slip, law = np.stack([one.slip for one in states]), np.stack([one.state for one in states])
    moved, closed = np.ptp(slip, axis=0), law != OPEN
    sticks = closed.all(axis=0) & (
        moved <= _STUCK * np.max(moved, where=closed.any(axis=0), initial=0.0)
    )
    stuck = np.flatnonzero(sticks)
    if len(stuck) < _ZONE or np.diff(stuck).max() > 1:
        return nothing
    value, scatter, edges = 0.0, [0.0, 0.0], 0
    for side in (1, -1):
        found = [_at_stick_edge(problem, states, slip, law, sticks, side)]
        if found[0] is not None:
            found.append(_at_contact_edge(problem, states, slip, side))
        for number, one in enumerate(found):
            if one is not None:  # the two edges of a zone mostly stand alike in their elements
                value, scatter[number], edges = value + one[0], scatter[number] + one[1], edges + 1
    problem.work["edges between nodes, taken off the dissipation"] += edges
    return Excess(value, math.hypot(*scatter), edges)


def _at_stick_edge(
    problem: ContactProblem,
    states: Sequence[InterfaceState],
    slip: Array,
    law: States,
    sticks: Mask,
    side: int,
) -> tuple[float, float] | None:
    """Work in excess and its rms over places, at the edge of permanent stick on that side of x = 0.

    Locked-in shear brings a node beside the edge nearer to the cone at one turn, and further from
    it at the other. So its distances at both turns are added.
    """
    first, last = (
        int(np.flatnonzero(sticks)[number]) for number in ((0, -1) if side > 0 else (-1, 0))
    )
    node, opposite = last + side, first - side
    if not _regular(problem, node):
        return None
    moved, turns = float(np.ptp(slip[:, node])), {}
    for sign in (1, -1):
        ends = (slip_sign(law[:, node]) == sign) & (
            sign * slip[:, node] >= np.max(sign * slip[:, node]) - _TURNED * moved
        )
        if not ends.any():
            return None
        turns[sign] = states[int(np.flatnonzero(ends)[-1])]
        if not turns[sign].is_complete:
            return None
    lacks = sum(
        problem.friction * turn.pressure[last] - sign * turn.shear[last]
        for sign, turn in turns.items()
    )
    value, scatter, loads = 0.0, 0.0, states[0].loads
    for sign, turn in turns.items():
        # Nodes that have only reached the cone stick.
        slides = np.where(sticks & (turn.state != OPEN), STICK, turn.state).astype(np.int8)
        beyond = slip_sign(slides) == sign
        if np.count_nonzero(beyond[node:] if side > 0 else beyond[: node + 1]) < _ZONE - 1:
            return None
        by_load = nodal(problem.rates(slides, len(loads))[1])
        way = (
            _way(moved, by_load[0][node]),
            _way(lacks, problem.friction * by_load[1][last] - sign * by_load[2][last]),
        )
        if not 0 < sum(way) < math.inf:
            return None
        share, unit = _chord(problem, node, True, way[0] / sum(way), sum(way))
        both = (node, opposite) if 0 <= opposite < len(beyond) and beyond[opposite] else (node,)
        jump = _jump(lambda one: nodal(problem.rates(one, len(loads))[1])[0], slides, both, STICK)
        work = problem.friction * float(turn.pressure @ jump) * unit
        value, scatter = value - work * float(share), scatter + abs(work) * _RMS
    return value, scatter


def _at_contact_edge(
    problem: ContactProblem, states: Sequence[InterfaceState], slip: Array, side: int
) -> tuple[float, float] | None:
    """The same at the edge of contact, on its way: along each increment p is linear in P, and no
    node touches or lets go.
    """
    rates: dict[bytes, Array] = {}

    def by_load(state: States) -> Array:
        """(4, n) rates by P: of like bodies they depend on what is closed alone, of others they are
        those of full stick.
        """
        if problem.interface.coupling is not None:
            state = np.where(state != OPEN, STICK, OPEN).astype(np.int8)
        return rates.setdefault(
            (state != OPEN).tobytes(), nodal(problem.rates(state, len(states[0].loads))[0])
        )

    value, works = 0.0, dict[int, float]()
    for one in states:
        by_load(one.state)
    for one, other, moved in zip(
        states[:-1], states[1:], np.abs(np.diff(slip, axis=0)), strict=True
    ):
        closed = np.flatnonzero(one.closed)
        node = int(closed[-1 if side > 0 else 0])
        after = node + side
        if not moved.any():
            continue
        if not one.is_complete or not _regular(problem, node) or not 0 <= after < len(moved):
            return None
        _, pressed, _, opened = by_load(one.state)
        way = _way(one.pressure[node], pressed[node]), _way(one.gap[after], opened[after])
        if not 0 < sum(way) < math.inf:
            return None
        ends = np.array([way[0], way[0] + other.normal_load - one.normal_load]).clip(
            0.0, sum(way)
        ) / sum(way)
        share, unit = _chord(
            problem, node, False, np.array([ends[0], ends.mean(), ends[1]]), sum(way)
        )
        opposite = int(closed[0 if side > 0 else -1])
        both = (node, opposite) if _regular(problem, opposite) else (node,)
        work = (
            problem.friction
            * float(moved @ _jump(lambda state: by_load(state)[1], one.state, both, OPEN))
            * unit
        )
        value -= work * float(share @ [1, 4, 1]) / 6
        works[node] = works.get(node, 0.0) + abs(work)
    # The way from node to node has no mean: what counts is the longest stay between two.
    return value, max(works.values(), default=0.0) * _RMS


def _way(distance: float, rate: float) -> float:
    """How much load takes a node that far; infinite where load does not move it."""
    return float(distance) / abs(float(rate)) if rate else math.inf


def _jump(
    rates: Callable[[States], Array], state: States, nodes: tuple[int, ...], back: int
) -> Array:
    """What the first of some nodes made of the rates when it left the state `back`, as a mean over
    both orders of two nodes.
    """
    changes = []
    for others in {(), nodes[1:]}:
        after = state.copy()
        after[list(others)] = back
        before = after.copy()
        before[nodes[0]] = back
        changes.append(rates(after) - rates(before))
    return np.asarray(sum(changes) / len(changes))


def _regular(problem: ContactProblem, node: int) -> bool:
    """Whether quadratic elements of one size are around a node, and its neighbours on both sides
    may touch.
    """
    weights = problem.interface.weights
    if not 2 <= node < len(weights) - 2:
        return False
    corners, middles = sorted(
        (weights[node - 2 : node + 3 : 2].tolist(), weights[node - 1 : node + 2 : 2].tolist()),
        key=max,
    )
    return _SIMPSON[0] * max(corners) <= min(middles) and max(middles) <= _SIMPSON[1] * min(corners)


def _chord(
    problem: ContactProblem, node: int, inwards: bool, share: Array | float, way: float
) -> tuple[Array, float]:
    """g at an edge that is shares t of the way between a node and the next, inwards or outwards; A
    over the jump of the rates.
    """
    corner = bool(problem.interface.weights[node] < problem.interface.weights[node - 1])
    both = (_WAY**3 + (1 - _WAY) ** 3) / 6
    of_corner, of_middle = (both - _APART) / 2, (both + _APART) / 2
    jump = 0.5 + _APART * (1 / _WAY + 1 / (1 - _WAY))
    along = _WAY if corner == inwards else 1 - _WAY
    here, there, jump = (of_corner, of_middle, 1 - jump) if corner else (of_middle, of_corner, jump)
    t = np.asarray(share)
    return here + (there - here) * t - along**2 * t * (1 - t) / 2, way / (along * jump)
