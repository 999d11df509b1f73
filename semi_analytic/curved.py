"""Integrals over an arc of any smooth leg that was appended in full stick, for legs without formulas of their own.

# notation: P_x load at which a = |x|, t_x the time of the arc at which P = P_x

The inverse root of a traction, at t_x or before the arc, is taken away by t = t_x + y^2, and the rule for singular ends does the
rest; before the arc t_x is where P would be P_x at the rate with which the arc begins. Nodes are used where rounding puts them: y
is what the rounded time makes of it, so that y/sqrt(P - P_x) keeps its digits. Ranges are cut where the load passes a corner of
the profile.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from scenes import Leg
from semi_analytic.contact import Contact, corner_loads
from semi_analytic.legs import NORMAL_LOAD, change, rate
from semi_analytic.memory import Piece, front_time
from semi_analytic.quadrature import NODES, gauss, graded

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

Rise: TypeAlias = Callable[[Indices, Array, Array], Array]
"""Integrals at the points of these numbers from here to there, (m,) each."""

_CHUNK = 2_000_000
# Points at which the parts of an arc are tried, how often a part is halved, and what two halves may differ by of the largest.
_SAMPLE = 17
_HALVINGS = 6
_SETTLED = 1e-13
_QUARTERS = 4
_SHORT = 1 / 32
# Lengths of an arc by which the root may begin ahead of it at most.
_AHEAD = 100.0


def curved_shear(contact: Contact, piece: Piece, last: Array, x: Array, *cuts: float) -> Array:
    """Traction of a piece's arc up to the times `last` (n,) at |x| (k,), in parts between `cuts` too: shape (n, k) [stress]."""
    edge = contact.load(x)
    leg = piece.anchor.leg
    first, meets = _meets(piece, edge)
    below = np.maximum(piece.bottom - edge, 0.0)
    speed = np.maximum(rate(leg, NORMAL_LOAD, meets), np.finfo(float).tiny)
    start, ahead = np.sqrt(speed), np.minimum(below, _AHEAD * (piece.anchor.time - meets) * speed) / speed

    def rise(point: Indices, low: Array, high: Array) -> Array:
        begin, rest, on, before = meets[point, None], below[point, None], edge[point, None], ahead[point, None]
        first, final = (np.sqrt(end - meets[point] + ahead[point]) for end in (low, high))
        step, weight = graded(0.0 * low, (high - low) / (first + final))
        time = low[:, None] + step * (2 * first[:, None] + step)
        y = np.sqrt(time - begin + before)
        excess = rest + change(leg, NORMAL_LOAD, time, begin)
        there = (y > 0) & (excess > 0)
        safe = np.where(there, excess, np.finfo(float).eps * piece.anchor.normal)
        root = np.where(there, y / np.sqrt(safe), np.where(rest > 0, 0.0, 1 / start[point, None]))
        quotient = contact.root_quotient(x[point, None], safe, on + safe)
        return np.sum(weight * 2 * root * quotient * _force_rate(leg, time), axis=-1)

    shape, upmost = (len(last), len(x)), np.full(len(x), np.max(last, initial=first))
    parts = _refined(rise, meets, upmost, _corner_times(contact, piece, *cuts))
    return _in_parts(rise, np.broadcast_to(meets, shape), np.broadcast_to(last[:, None], shape), parts) / math.pi


def curved_slip(contact: Contact, piece: Piece, last: Array, x: Array, *cuts: float) -> Array:
    """int dQ arccosh(|x|/a) over the part of a piece's arc outside which |x| is: shape (n, k) [force per thickness].

    In parts between the times `cuts` too.
    """
    edge = contact.load(x)
    leg = piece.anchor.leg
    first, meets = _meets(piece, edge)
    beyond = np.maximum(edge - piece.anchor.normal, 0.0)

    def rise(point: Indices, low: Array, high: Array) -> Array:
        time, weight = graded(low, high)
        excess = np.maximum(beyond[point, None] + change(leg, NORMAL_LOAD, meets[point, None], time), 0.0)
        reach = contact.reach(x[point, None], excess, leg.loads(time)[0])
        return np.sum(weight * reach * _force_rate(leg, time), axis=-1)

    end, begin = np.minimum(last[:, None], meets), np.full(len(x), first)
    parts = _refined(rise, begin, np.max(end, axis=0, initial=first), _corner_times(contact, piece, *cuts))
    return _in_parts(rise, np.broadcast_to(begin, end.shape), end, parts)


def curved_log(contact: Contact, piece: Piece, last: Array) -> Array:
    """int dQ ln(2 L/a) over a piece's arc up to the times `last` (n,): shape (n,) [force per thickness].

    Each less the one before: what n arcs from one lower end have in common is integrated once, between neighbours by Gauss' rule
    where they are closer to each other than to any place at which the logarithm is singular or P(a) has a corner.
    """
    assert piece.arc is not None
    leg, first, whole = piece.anchor.leg, piece.arc[0], piece.anchor.time
    corners = _corner_times(contact, piece)
    end = float(np.max(last, initial=first))

    def by(rule: Callable[[Array, Array], tuple[Array, Array]], low: Array, high: Array) -> Array:
        time, weight = rule(low, high)
        return np.sum(weight * contact.log_ratio(leg.loads(time)[0]) * _force_rate(leg, time), axis=-1)

    # Never in less than quarters: swift harmonics over a long range are not what the rules are best at.
    cuts = np.sort(np.append(corners, np.linspace(first, end, _QUARTERS + 1)))
    parts = _refined(lambda _, low, high: by(graded, low, high), np.array([first]), np.array([end]), cuts)
    marks = np.unique(np.clip(np.concatenate([last, parts]), first, end))
    low, high = marks[:-1], marks[1:]
    rough = np.unique(np.concatenate([[first, whole], corners]))
    before = rough[np.maximum(np.searchsorted(rough, low, side="right") - 1, 0)]
    after = rough[np.minimum(np.searchsorted(rough, high), len(rough) - 1)]
    room = np.minimum(np.minimum(low - before, after - high), _SHORT * (whole - first))
    smooth = high - low <= room
    rises = np.zeros(len(marks))
    for here, rule in ((smooth, _gauss), (~smooth, graded)):
        rises[1:][here] = by(rule, low[here], high[here])
    return np.cumsum(rises)[np.searchsorted(marks, np.clip(last, first, end))]


def _gauss(begin: Array, end: Array) -> tuple[Array, Array]:
    """Gauss' rule on [begin, end], a new last axis: 1e-18 where no singularity is closer than the range is long."""
    node, weight = gauss(12)
    length = (end - begin)[:, None]
    return begin[:, None] + length * node, length * weight


def _meets(piece: Piece, edge: Array) -> tuple[float, Array]:
    """Time of the lower end of the arc, and the time at which P = P_x, kept inside the arc as it was appended."""
    assert piece.arc is not None
    return piece.arc[0], front_time(piece, edge)


def _force_rate(leg: Leg, time: Array) -> Array:
    return leg.rates(time)[1]


def _corner_times(contact: Contact, piece: Piece, *others: float) -> Array:
    """Times of the arc, as it was appended, at which its load is that of a corner, and others: ascending."""
    loads = corner_loads(contact)
    loads = loads[(loads > piece.bottom) & (loads < piece.anchor.normal)]
    times = front_time(piece, loads) if len(loads) else loads
    return np.sort(np.append(times, others)) if others else times


def _refined(rise: Rise, begin: Array, end: Array, cuts: Array) -> Array:
    """`cuts`, and halves of the parts between them where two halves are not the whole for some of the points, (k,) each: ascending.

    P(a) may bend sharply anywhere, a polynomial's that hardly grows, and the rule sees singularities beyond the ends only.
    """
    some = np.unique(np.linspace(0, len(begin) - 1, _SAMPLE).astype(int))
    begin, end = begin[some], end[some]

    def part(low: float, high: float) -> Array:
        first, last = np.maximum(begin, low), np.minimum(end, high)
        here, result = np.flatnonzero(last > first), np.zeros(len(some))
        if len(here):
            result[here] = rise(some[here], first[here], last[here])
        return result

    lowest, highest = float(np.min(begin, initial=math.inf)), float(np.max(end, initial=-math.inf))
    marks = [lowest, *cuts[(cuts > lowest) & (cuts < highest)].tolist(), highest]
    todo = [(low, high, part(low, high)) for low, high in pairwise(marks) if high > low]
    size, found = max((float(np.max(np.abs(whole))) for *_, whole in todo), default=0.0), list(cuts)
    for _ in range(_HALVINGS):
        ranges, todo = todo, []
        for low, high, whole in ranges:
            middle = (low + high) / 2
            halves = [(low, middle, part(low, middle)), (middle, high, part(middle, high))]
            if np.max(np.abs(whole - halves[0][2] - halves[1][2])) > _SETTLED * size:
                found.append(middle)
                todo += halves
    return np.sort(found)


def _in_parts(rise: Rise, begin: Array, end: Array, cuts: Array) -> Array:
    """Integrals from `begin` to `end` (n, k), cut at `cuts`: rise(point (m,), low (m,), high (m,)) gives those of parts, (m,)."""
    total = np.zeros(begin.shape)
    for lower, upper in pairwise([-math.inf, *cuts.tolist(), math.inf]):
        low, high = np.maximum(begin, lower), np.minimum(end, upper)
        row, point = np.nonzero(high > low)
        for j in range(0, len(row), _CHUNK // NODES):
            here = row[j : j + _CHUNK // NODES], point[j : j + _CHUNK // NODES]
            total[here] += rise(here[1], low[here], high[here])
    return total
