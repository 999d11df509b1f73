"""Integrals over an arc of any smooth leg that was appended in full stick, for legs without formulas of their own.

# notation: P_x load at which a = |x|, t_x the time of the arc at which P = P_x

The inverse root of a traction, at t_x or just before the arc, is taken away by t = begin + y^2, and the rule for singular ends does
the rest. Nodes are used where rounding puts them: y is what the rounded time makes of it, so that y/sqrt(P - P_x) keeps its digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from scenes import Leg
from semi_analytic.contact import Contact
from semi_analytic.legs import NORMAL_LOAD, change, rate, time_of
from semi_analytic.memory import Piece
from semi_analytic.quadrature import NODES, graded

Array = NDArray[np.float64]

_CHUNK = 2_000_000
_QUARTERS = 4


def curved_shear(contact: Contact, piece: Piece, last: Array, x: Array) -> Array:
    """Traction of a piece's arc up to the times `last` (n,) at |x| (k,): shape (n, k) [stress]."""
    edge = contact.load(x)
    _, meets = _meets(piece, edge)

    def rows(ends: Array) -> Array:
        begin = np.broadcast_to(meets, (len(ends), len(x)))
        span = np.maximum(ends[:, None] - begin, 0.0)
        y, weight = graded(np.zeros(span.shape), np.sqrt(span))
        time = begin[..., None] + y * y
        y = np.sqrt(time - begin[..., None])
        below = np.maximum(piece.bottom - edge, 0.0)[:, None]
        excess = below + change(piece.anchor.leg, NORMAL_LOAD, time, begin[..., None])
        start = np.sqrt(np.maximum(rate(piece.anchor.leg, NORMAL_LOAD, begin), np.finfo(float).tiny))[..., None]
        there = (y > 0) & (excess > 0)
        safe = np.where(there, excess, np.finfo(float).eps * piece.anchor.normal)
        root = np.where(there, y / np.sqrt(safe), np.where(below > 0, 0.0, 1 / start))
        quotient = contact.root_quotient(x[:, None], safe, edge[:, None] + safe)
        return np.sum(weight * 2 * root * quotient * _force_rate(piece.anchor.leg, time), axis=-1)

    return _in_chunks(rows, last, len(x)) / math.pi


def curved_slip(contact: Contact, piece: Piece, last: Array, x: Array) -> Array:
    """int dQ arccosh(|x|/a) over the part of a piece's arc outside which |x| is: shape (n, k) [force per thickness]."""
    edge = contact.load(x)
    leg = piece.anchor.leg
    first, meets = _meets(piece, edge)
    beyond = np.maximum(edge - piece.anchor.normal, 0.0)[:, None]

    def rows(ends: Array) -> Array:
        end = np.minimum(ends[:, None], meets)
        time, weight = graded(np.full(end.shape, first), end)
        excess = np.maximum(beyond + change(leg, NORMAL_LOAD, meets[:, None], time), 0.0)
        return np.sum(weight * contact.reach(x[:, None], excess, leg.loads(time)[0]) * _force_rate(leg, time), axis=-1)

    return _in_chunks(rows, last, len(x))


def curved_log(contact: Contact, piece: Piece, last: Array) -> Array:
    """int dQ ln(2 L/a) over a piece's arc up to the times `last` (n,): shape (n,) [force per thickness]."""
    assert piece.arc is not None
    leg = piece.anchor.leg
    # In quarters: swift harmonics over a long range are not what the rule is best at.
    marks = piece.arc[0] + (last[:, None] - piece.arc[0]) * np.linspace(0, 1, _QUARTERS + 1)
    time, weight = graded(marks[:, :-1], marks[:, 1:])
    return np.sum(weight * contact.log_ratio(leg.loads(time)[0]) * _force_rate(leg, time), axis=(-2, -1))


def _meets(piece: Piece, edge: Array) -> tuple[float, Array]:
    """Time of the lower end of the arc, and the time at which P = P_x, kept inside the arc as it was appended."""
    assert piece.arc is not None
    first, whole = piece.arc[0], piece.anchor.time
    return first, time_of(piece.anchor.leg, NORMAL_LOAD, edge - piece.bottom, first, whole)


def _force_rate(leg: Leg, time: Array) -> Array:
    return leg.rates(time)[1]


def _in_chunks(rows: Callable[[Array], Array], last: Array, width: int) -> Array:
    step = max(_CHUNK // (width * NODES), 1)
    return np.concatenate([rows(last[k : k + step]) for k in range(0, len(last), step)])
