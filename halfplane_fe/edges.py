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


def contact_uncertainty(x: Array, pressure: Array, closed: Mask, contact: tuple[float, float]) -> tuple[float, float]:
    """How far each contact edge may be from the true one, by the mesh.

    A share of the distance of the nodes around it, and how far the edge is from another estimate: the zero of a straight line
    through the squares of the pressure at the five nodes before the last. With fewer nodes than that, the whole contact.

    Parameters
    ----------
    x, pressure, closed : (n,) nodes in ascending order
    contact : left and right end of the contact
    """
    inside = np.flatnonzero(closed)
    if len(inside) <= len(_EXTRAPOLATED):
        return (contact[1] - contact[0],) * 2
    found = []
    for last, step, edge in ((int(inside[0]), -1, contact[0]), (int(inside[-1]), 1, contact[1])):
        nodes = last - step * _EXTRAPOLATED
        slope, value = np.polyfit(step * (x[nodes] - x[last]), pressure[nodes] ** 2, 1)
        other = x[last] - step * value / slope if slope < 0 else x[nodes[-1]]
        found.append(_SHARE * _spacing(x, last) + min(abs(float(other) - edge), abs(x[nodes[-1]] - edge)))
    return found[0], found[1]


def stick_edges(
    x: Array, stick: Mask, closed: Mask, contact: tuple[float, float], limit: Array | None = None, shear: Array | None = None
) -> tuple[float, float]:
    """Left and right end of the stick zone; the contact edges where the whole contact sticks, NaN where nothing does.

    By node status the edge lies half-way between the last node of the stick zone and the first one of the slip zone: on each side
    of the middle of the contact where the fewest nodes are on the wrong side of it (a node that has just come to touch sticks at
    the rim of the slip zone, and a single one may slide at the rim of a contact that sticks). Where `limit` (f p) and `shear` are
    given, the edge is fitted where it can be, see `fitted_stick_edge`.

    Parameters
    ----------
    x, stick, closed : (n,) nodes in ascending order and what they do
    contact : left and right end of the contact
    limit, shear : (n,) f p and q [stress]
    """
    edges = []
    for side, step, end in _halves(x, closed, contact):
        n_stick = _fewest_wrong(stick[side])
        if n_stick == 0 and len(side):
            return float("nan"), float("nan")
        if n_stick == len(side):
            edges.append(end)
            continue
        last = int(side[n_stick - 1])
        by_status = float(x[last] + x[last + step]) / 2
        fitted = None
        if limit is not None and shear is not None and n_stick > _FITTED.max():
            fitted = fitted_stick_edge(x, limit - np.sign(shear[last + step]) * shear, last, step)
        outside = fitted is not None and step * (fitted - end) > 0  # nothing sticks beyond the contact: a fit gone wrong
        edges.append(by_status if fitted is None or outside else fitted)
    return edges[0], edges[1]


def stick_uncertainty(
    x: Array,
    seen: tuple[Mask, Mask],
    closed: Mask,
    contact: tuple[float, float],
    edges: tuple[float, float],
    of_contact: tuple[float, float],
) -> tuple[float, float]:
    """How far each stick edge may be from the true one, by the mesh; NaN where nothing sticks.

    Where the whole contact sticks, a slip zone narrower than a node may be there unseen, and the contact edge itself is uncertain.
    Else the distance of the nodes around the edge (a share of it where the edge is fitted), and how far the edge is from where it
    would be by another reading of the states: node status for a fitted one, and creeping nodes counted as sliding. A slip zone of
    a few nodes may be none at all: there, at least the distance to the contact edge.

    Parameters
    ----------
    seen : (n,) nodes that stick, as the reader sees them and by the law alone
    contact, edges : contact and stick edges as answered
    of_contact : uncertainty of the contact edges
    """
    if np.isnan(edges[0]):
        return float("nan"), float("nan")
    by_status, by_law = (stick_edges(x, sticking, closed, contact) for sticking in seen)
    found = []
    for side, (nodes, step, end) in enumerate(_halves(x, closed, contact)):
        edge = edges[side]
        apart = [abs(other[side] - edge) for other in (by_status, by_law) if np.isfinite(other[side])]
        beyond = int(np.count_nonzero(step * (x[nodes] - edge) > 0))
        spacing = _spacing(x, int(np.argmin(np.abs(x - edge))))
        if edge == end:
            found.append(max(spacing, of_contact[side], *apart))
            continue
        narrow = abs(end - edge) + of_contact[side] if beyond <= _UNRESOLVED else 0.0
        share = 1.0 if edge == by_status[side] else _FITTED_SHARE
        found.append(max(share * spacing + max(apart), narrow))
    return found[0], found[1]


def _halves(x: Array, closed: Mask, contact: tuple[float, float]) -> tuple[tuple[NDArray[np.intp], int, float], ...]:
    """Closed nodes left and right of the middle of the contact, from there outwards, with the direction and the contact edge."""
    nodes = np.flatnonzero(closed)
    middle = int(np.searchsorted(x[nodes], (x[nodes[0]] + x[nodes[-1]]) / 2))
    return (nodes[:middle][::-1], -1, contact[0]), (nodes[middle:], 1, contact[1])


def _spacing(x: Array, node: int) -> float:
    """The larger distance of a node from its neighbours."""
    return float(np.max(np.abs(x[[max(node - 1, 0), min(node + 1, len(x) - 1)]] - x[node])))


# Share of the distance of two nodes by which an edge between them is uncertain whatever the fit says: the shape functions of
# quadratic elements know no square root. Measured on hertz-paper, cattaneo-mindlin and flat-rounded-paper: 0.26 at most.
_SHARE = 0.3
# The same of a fitted stick edge, whose straight line is a chord: on elements of a/60 that costs flat-rounded-paper so much.
_FITTED_SHARE = 0.5
# Nodes that the second estimate of the contact edge takes, counted from the last closed one.
_EXTRAPOLATED = np.arange(1, 6)
# Nodes of a slip zone below which it may be none at all.
_UNRESOLVED = 4
# Nodes inside the stick zone that the fit takes, counted from its last one, which the singularity spoils.
_FITTED = np.arange(1, 8)
# Elements by which two fits of a stick edge may differ.
_AGREE = 0.1


def fitted_stick_edge(x: Array, room: Array, last: int, step: int) -> float | None:
    """Edge of the stick zone from the shear inside it: f p -+ q falls to zero as the square root of the distance.

    Parameters
    ----------
    x : (n,) nodes
    room : (n,) f p less the shear in the direction of the slip beyond the edge [stress]
    last : last node of the stick zone by its status
    step : 1 for a right edge, -1 for a left one

    Returns
    -------
    The zero of a straight line through the squares of `room` at seven nodes; None where they do not fall towards the edge, where
    the line through the next four says something else (an older stick edge is near), or where the zero is not near the last node.
    """
    element = abs(x[last] - x[last - 2 * step])
    found = []
    for count in (len(_FITTED), 4):
        nodes = last - step * _FITTED[:count]
        slope, value = np.polyfit(step * (x[nodes] - x[last]), room[nodes] ** 2, 1)
        if slope >= 0:
            return None
        found.append(float(x[last] - step * value / slope))
    agree = abs(found[0] - found[1]) <= _AGREE * element and abs(found[0] - x[last]) <= element
    return found[0] if agree else None


def _fewest_wrong(stick: Mask) -> int:
    """How many of a row of nodes, from the middle outwards, to count as sticking; the more where it is a tie."""
    sliding_inside = np.concatenate([[0], np.cumsum(~stick)])
    sticking_outside = np.concatenate([np.cumsum(stick[::-1])[::-1], [0]])
    wrong = sliding_inside + sticking_outside
    return int(len(wrong) - 1 - np.argmin(wrong[::-1]))
