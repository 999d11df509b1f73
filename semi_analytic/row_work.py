"""Friction work of the records that a stack leaves: along each of them P, P_c and the level w are linear in one another.

# notation: A = 2/E*; P_c load at the front of slip, c = a(P_c); w level +-Q - f P; P_x load at which a = |x|

W = (f A/pi) int Lam(P, P_c) dw,  W(x) = (f A/pi) int p(x, P) arccosh(|x|/c) dw over c < |x| < a(P).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes import NotFoundError
from semi_analytic.contact import Contact, bends_anywhere, corner_loads
from semi_analytic.quadrature import NODES, ROOTS, gauss, graded
from semi_analytic.stack import Records

Array = NDArray[np.float64]

_CHUNK = 200_000
# Nodes of Gauss' rule while P and P_c change by less than a share: 3e-13 by the distance of the singularity. Above, graded.
_RULE, _SAMPLE = 3e-13, 200
_RULES = ((0.05, 4), (0.3, 6), (0.6, 12), (0.9, 24))
# Half-widths over the largest: 7 % apart a root of dP/da at 0.73 +- 0.24 i leaves 4e-14 of W, 16 % apart 2e-11.
_LADDER = 2.0 ** -np.arange(0.1, 5.0, 0.1)


def _crowded(count: int) -> tuple[Array, Array]:
    """Gauss' rule in t on [0, 1] of 3 t^2 - 2 t^3."""
    t, weight = gauss(count)
    return t * t * (3 - 2 * t), weight * 6 * t * (1 - t)


_CROWDED = _crowded(24)


def slip_work(contact: Contact, records: Records) -> Array:
    """int Lam dw of each record (m,) [force^2 per thickness^2]."""
    corners, cuts = corner_loads(contact), _cuts(contact, records)
    if not len(cuts):
        return _smooth_work(contact, records, corners)
    parts = _cut_at(cuts, records)
    return np.bincount(parts.row, _smooth_work(contact, parts, corners), len(records.row)).astype(float)


def _cuts(contact: Contact, records: Records) -> Array:
    """Loads of corners and, where P may hardly grow anywhere, of half-widths so close that a(P) is smooth in between."""
    corners = corner_loads(contact)
    if not bends_anywhere(contact) or not len(records.row):
        return corners
    largest = contact.half_width(max(float(np.max(records.load)), float(np.max(records.load_after))))
    return np.append(corners, contact.load(largest * _LADDER))


def work_error(contact: Contact, records: Records) -> float:
    """Error of the sum of `slip_work` from above, by a sample of records; 0 for closed forms [force^2 per thickness^2]."""
    if contact.closed_form or not len(records.row):
        return 0.0
    some = np.unique(np.linspace(0, len(records.row) - 1, _SAMPLE).astype(int))
    load = np.concatenate([records.load[some], records.load_after[some]])
    slipped = np.maximum(load - np.concatenate([records.front[some], records.front_after[some]]), 0.0)
    area = contact.log_area(load, slipped)
    left = contact.quadrature_error("log_area", load, slipped) + _RULE * area
    if not np.all(np.isfinite(left)):
        raise NotFoundError("the error of a slip area is not a number: neither is the dissipation of these rows")
    return float(np.max(left, initial=0.0) * np.sum(records.rise))


def _cut_at(loads: Array, records: Records) -> Records:
    """The records, each cut where P or P_c is one of some loads; `row` is then the number of the record."""
    parts = records._replace(row=np.arange(len(records.row)))
    for load in loads.tolist():
        for begin_name, end_name in (("load", "load_after"), ("front", "front_after")):
            begin, end = getattr(parts, begin_name), getattr(parts, end_name)
            through = np.flatnonzero((begin - load) * (end - load) < 0)
            if len(through):
                parts = _cut(parts, through, ((load - begin[through]) / (end - begin)[through]))
    return parts


def _cut(records: Records, which: NDArray[np.intp], share: Array) -> Records:
    """The records with some of them in two, at shares (k,) of their length."""
    load = records.load[which] + share * (records.load_after - records.load)[which]
    front = records.front[which] + share * (records.front_after - records.front)[which]
    second = Records._make(values[which] for values in records)._replace(load=load, front=front)
    second = second._replace(rise=(1 - share) * second.rise)
    first = Records._make(values.copy() for values in records)
    first.load_after[which], first.front_after[which] = load, front
    first.rise[which] *= share
    return Records._make(np.concatenate(pair) for pair in zip(first, second, strict=True))


def _smooth_work(contact: Contact, records: Records, corners: Array) -> Array:
    slip = np.maximum(records.load - records.front, 0.0)
    slip_after = np.maximum(records.load_after - records.front_after, 0.0)
    # Along a record P and P_c are linear; the integrand is singular where either would be 0, beyond an end, if they went on, and
    # where it would be at the corner below: as d^(3/2) only, which nodes that crowd to both ends resolve.
    ends = [
        (np.minimum(*pair), np.maximum(*pair))
        for pair in ((records.load, records.load_after), (records.front, records.front_after))
    ]
    share = np.maximum(*(_share(*pair, np.empty(0)) for pair in ends))
    behind = np.maximum(*(_share(*pair, corners) for pair in ends)) > np.maximum(share, _RULES[0][0])
    result = np.zeros(len(slip))
    below = -1.0
    for limit, count in (*_RULES, (np.inf, 0)):
        here = np.flatnonzero((share > below) & (share <= limit) & ~(behind & (count > 0)))
        below = limit
        part, weight = gauss(count) if count else (ROOTS.up, ROOTS.share)
        result[here] = _by_rule(contact, records, here, slip, slip_after, part, weight)
    here = np.flatnonzero(behind & (share <= _RULES[-1][0]))
    result[here] = _by_rule(contact, records, here, slip, slip_after, *_CROWDED)
    return result


def _by_rule(
    contact: Contact, records: Records, here: NDArray[np.intp], slip: Array, slip_after: Array, part: Array, weight: Array
) -> Array:
    """int Lam dw of some records by nodes and weights on [0, 1]."""
    result = np.empty(len(here))
    size = _CHUNK // len(part) + 1
    for k in range(0, len(here), size):
        some = here[k : k + size]
        load = records.load[some, None] + (records.load_after - records.load)[some, None] * part
        slipped = slip[some, None] + (slip_after - slip)[some, None] * part
        area = contact.log_area(load, np.minimum(slipped, load))
        result[k : k + size] = records.rise[some] * np.sum(weight * area, axis=1)
    return result


def _share(low: Array, high: Array, corners: Array) -> Array:
    """How much of the way to the corner below `high`, or to 0, a range takes: 1 - low/high counted from there."""
    base = np.append(0.0, corners)[np.searchsorted(corners, (low + high) / 2)]
    return 1 - np.maximum(low - base, 0.0) / np.maximum(high - base, np.finfo(float).tiny)


def density_of_records(contact: Contact, records: Records, x: Array) -> Array:
    """int p arccosh(|x|/c) dw of all records at |x| = `x` (k,): shape (k,) [stress * force per thickness]."""
    edge = contact.load(x)
    total = np.zeros(len(x))
    cuts = _cuts(contact, records)
    records = _cut_at(cuts, records) if len(cuts) else records
    size = max(_CHUNK // len(x), 1)
    for k in range(0, len(records.row), size):
        some = Records._make(values[k : k + size] for values in records)
        begin, end = _slip_shares(some, edge)
        which, point = np.nonzero(end > begin)
        for j in range(0, len(which), _CHUNK // NODES):
            pair = slice(j, j + _CHUNK // NODES)
            w, i = which[pair], point[pair]
            part, weight = graded(begin[w, i], end[w, i])
            load, front = (some[a][w, None] * (1 - part) + some[b][w, None] * part for a, b in ((1, 2), (3, 4)))
            reach = contact.reach(x[i, None], np.maximum(edge[i, None] - front, 0.0), front)
            work = some.rise[w] * np.sum(weight * contact.pressure(x[i, None], load) * reach, axis=1)
            total += np.bincount(i, work, len(x))
    return total


def _slip_shares(records: Records, edge: Array) -> tuple[Array, Array]:
    """Between which parts of each record (m, k) points of edge load (k,) are in contact and outside the front."""
    front, drop = records.front[:, None], (records.front - records.front_after)[:, None]
    begin = np.clip((front - edge) / np.where(drop > 0, drop, 1.0), 0.0, 1.0)
    begin = np.where(edge >= front, 0.0, np.where(drop > 0, begin, 1.0))
    load, growth = records.load[:, None], (records.load_after - records.load)[:, None]
    meets = np.clip((edge - load) / np.where(growth != 0, growth, 1.0), 0.0, 1.0)
    inside = edge < np.maximum(load, load + growth)
    end = np.where(inside, np.where(growth < 0, meets, 1.0), 0.0)
    return np.where(growth > 0, np.maximum(begin, meets), begin), end
