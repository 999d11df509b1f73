"""Contact and stick edges from nodal answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def contact_edge(pressed_at: float, pressure: float, open_at: float, gap: float, modulus: float) -> float:
    r"""Edge between the last closed and the first open node, from the form that every smooth edge has.

    With d the distance from the edge and one unknown factor beta, p = (E*/2) beta sqrt(d) inside, g = (2/3) beta d^(3/2) outside;
    the two nodes give beta and the edge.

    Parameters
    ----------
    pressed_at, open_at : places of the two nodes [length]
    pressure, gap : pressure of the first [stress], gap of the second [length]; both >= 0
    modulus : E* [stress]
    """
    span = open_at - pressed_at
    if pressure <= 0 or gap <= 0:
        return pressed_at if pressure <= 0 else open_at

    def mismatch(inside: float) -> float:  # grows with the share `inside` of the closed node
        return pressure * 4 / (3 * modulus) * (abs(span) * (1 - inside)) ** 1.5 - gap * (abs(span) * inside) ** 0.5

    return pressed_at + span * float(brentq(mismatch, 0.0, 1.0, xtol=1e-14))


def contact_edges(x: Array, pressure: Array, gap: Array, closed: Mask, modulus: float) -> tuple[float, float]:
    """Left and right end of the contact; the outermost node itself where no open node follows.

    Parameters
    ----------
    x, pressure, gap, closed : (n,) nodes in ascending order
    """
    inside = np.flatnonzero(closed)
    edges = []
    for last, step in ((int(inside[0]), -1), (int(inside[-1]), 1)):
        following = last + step
        if not 0 <= following < len(x):
            edges.append(float(x[last]))
            continue
        edges.append(contact_edge(x[last], pressure[last], x[following], gap[following], modulus))
    return edges[0], edges[1]


def stick_edges(x: Array, stick: Mask, closed: Mask, contact: tuple[float, float]) -> tuple[float, float]:
    """Left and right end of the stick zone: half-way between its last node and the first one of the slip zone.

    The contact edges where the whole contact sticks, NaN where nothing does. On each side of the middle of the contact the edge is
    where the fewest nodes are on the wrong side of it: a node that has just come to touch sticks at the rim of the slip zone, and
    a single one may slide at the rim of a contact that sticks.
    """
    nodes = np.flatnonzero(closed)
    middle = int(np.searchsorted(x[nodes], (x[nodes[0]] + x[nodes[-1]]) / 2))
    edges = []
    for side, step, end in ((nodes[:middle][::-1], -1, contact[0]), (nodes[middle:], 1, contact[1])):
        n_stick = _fewest_wrong(stick[side])
        if n_stick == 0 and len(side):
            return float("nan"), float("nan")
        if n_stick == len(side):
            edges.append(end)
            continue
        last = int(side[n_stick - 1])
        edges.append(float(x[last] + x[last + step]) / 2)
    return edges[0], edges[1]


def _fewest_wrong(stick: Mask) -> int:
    """How many of a row of nodes, from the middle outwards, to count as sticking; the more where it is a tie."""
    sliding_inside = np.concatenate([[0], np.cumsum(~stick)])
    sticking_outside = np.concatenate([np.cumsum(stick[::-1])[::-1], [0]])
    wrong = sliding_inside + sticking_outside
    return int(len(wrong) - 1 - np.argmin(wrong[::-1]))
