"""Friction work, over the whole contact and point by point, of any history; and a second way to the
former.

# notation: A = 2/E*; w = +-Q - f P, which grows in slip; P_c load at the front of slip, c = a(P_c);
P_x load at which a = |x|

    W    = (f A/pi) int w' Lam(P, P_c) dt,                  Lam = int_{P_c}^P ln(a(eta)/c) d eta
    W(x) = (f A/pi) int p(x, P) w' arccosh(|x|/c) dt        over the times with c < |x| < a(P)
    W    = closed-int Q dU                                  over a steady cycle

Each span of slip is integrated in time by one rule for singular ends: roots at the edges of the
contact, the logarithm of gross sliding, P close to 0 all lie at an end of a span or beyond it. On
legs and arcs without formulas the front may run unevenly in the middle of a span as well, and so
may all edges where P(a) hardly grows at one load; and edges pass corners of the profile. There a
rule of fewer nodes is applied to the span, to parts of it, cut at a corner or in the middle, and to
parts of these, until that changes nothing: fine tables are cut at a few of their knots.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import NORMAL_LOAD, Combination, NotFoundError
from scenes.segments import LEAST
from semi_analytic.fields import Integrals
from semi_analytic.history import Span, corner_times, take
from semi_analytic.load_series import Records, StepBlock
from semi_analytic.memory import change_from, level, level_on
from semi_analytic.profiles import Contact
from semi_analytic.quadrature import NODES, ROOTS, crowded, gauss, graded
from semi_analytic.tilted_profile import TiltedProfile

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CONVERGED = 1e-12
# How often a range is halved at most: parts of 1/131,072 of it are left as they are; and all parts
# where they are more than so many an integral and a few hundred: what is left to halve then is the
# last digits of loads along which next to nothing slips.
_HALVINGS, _MOST, _FEW = 17, 64, 256
# Share of U, as a sum of logarithms times loads, that its last digits may be off.
_DIGITS_OF_SHIFT = 5e-16
# Nodes of Gauss' rule while P and P_c change by less than a share: 3e-13 by the distance of the
# singularity. Above, graded, which takes 193: a million rows would take ten times as long. Close
# behind a corner, 24 that crowd to both ends.
_RULE, _SHARES, _COUNTS = 3e-13, (0.05, 0.3, 0.6, 0.9), (4, 6, 12, 24)
# Records of a block that are looked at for the error of W.
_SAMPLE = 200
# Half-widths over the largest: 7 % apart a root of dP/da at 0.73 +- 0.24 i leaves 4e-14 of W, 16 %
# apart 2e-11.
_LADDER = 2.0 ** -np.arange(0.1, 5.0, 0.1)
# Quadrature nodes that are held at a time.
_CHUNK = 200_000


class Split(NamedTuple):
    """Friction work done while slipping forward and while slipping in reverse, and an estimate of
    the error of both together.
    """

    forward: Array
    reverse: Array
    error: Array

    @property
    def total(self) -> Array:
        """Both together."""
        return self.forward + self.reverse


def global_dissipation(contact: Contact, modulus: float, spans: Sequence[Span]) -> Split:
    """Friction work of the spans over the whole contact [energy per unit thickness].

    Of Q from 0 to k f P at constant P: (A f^2 P^2/(2 pi)) [(1 - k) ln(1 - k) + k - k^2/2].

    >>> from scenes.segments import straight_segments
    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.history import march
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> spans, _ = march(
    ...     None, straight_segments([(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 1.0, 0.3)]), 0.5, 0.0
    ... )  # k = 0.6
    >>> closed = 0.5**2 / math.pi * (0.4 * math.log(0.4) + 0.6 - 0.18)
    >>> round(float(global_dissipation(contact, 1.0, spans).total), 12), round(closed, 12)
    (0.004256098192, 0.004256098192)
    """
    parts = [_whole(span) for span in spans if span.direction and span.active is not None]

    def work(span: Span, _: Indices, low: Array, high: Array, rule: Rule) -> Array:
        times, weights = rule(low, high)
        area = contact.dissipation_kernel(span.leg.loads(times)[0], span.slipped(times))
        return np.asarray(np.sum(weights * _growth(span, times) * area, axis=-1))

    return Split(*(part[0] for part in _over_spans(contact, modulus, parts, 1, work)))


Part = tuple[Span, Array, Array]
"""A span, and when the integrals along it begin and end, (k,) each; nothing where the end is not
after the begin.
"""


def _whole(span: Span) -> Part:
    return span, np.array([span.begin.time]), np.array([span.end.time])


def _over_spans(
    contact: Contact,
    modulus: float,
    parts: Sequence[Part],
    count: int,
    integral: Callable[[Span, Indices, Array, Array, Rule], Array],
) -> Split:
    """A/pi times the sums of `count` integrals along spans: by one rule, or by halving where edges
    run unevenly or pass corners.

    `integral`(span, which (n,), low (n,), high (n,), rule) gives number which[k] from low[k] to
    high[k], (n,).
    """
    marks = [corner_times(contact, span) for span, *_ in parts]
    rough = np.array(
        [
            len(cuts) > 0 or uneven(contact, part[0])
            for cuts, part in zip(marks, parts, strict=True)
        ],
        dtype=bool,
    )
    values, errors = np.zeros((2, len(parts), count))
    for number, (span, begin, end) in enumerate(parts):
        some = np.flatnonzero(end > begin)
        if len(some):
            values[number, some] = integral(
                span, some, begin[some], end[some], crowded if rough[number] else graded
            )
    # One size for all: a short span by itself may be all rounding, and would never converge to its
    # own.
    size = float(np.max(np.abs(np.sum(values, axis=0))))
    for number in np.flatnonzero(rough).tolist():
        span, begin, end = parts[number]
        some = np.flatnonzero(end > begin)
        if not len(some):
            continue

        def part(
            which: Indices, low: Array, high: Array, span: Span = span, some: Indices = some
        ) -> Array:
            return integral(span, some[which], low, high, crowded)

        # 1e-14 across corners, for many small kinks may hide from one halving.
        share = min(CONVERGED, 25 * contact.noise) if len(marks[number]) else CONVERGED
        allowed = share * max(size, float(np.max(np.abs(values[number]))))
        values[number, some], errors[number, some] = by_halving(
            part, begin[some], end[some], allowed, marks[number]
        )
    forward, factor = (
        np.array([span.direction > 0 for span, *_ in parts], dtype=bool),
        2 / (math.pi * modulus),
    )
    return Split(
        *(factor * np.sum(each, axis=0) for each in (values[forward], values[~forward], errors))
    )


Rule = Callable[[ArrayLike, ArrayLike], tuple[Array, Array]]


def _growth(span: Span, times: Array) -> Array:
    """f times the rate at which the level of a span of slip grows; >= 0."""
    return span.friction * np.maximum(
        span.leg.rate_of(level(span.direction, span.friction), times), 0.0
    )


def uneven(contact: Contact, span: Span) -> bool:
    """Whether the load, or the front along an arc, runs by no formula, or the edges of contact and
    stick do at any load.
    """
    if contact.bends_anywhere:
        return True
    arc = span.active is not None and span.active.arc is not None
    return span.leg.ellipse is None and (
        arc or not (span.leg.is_straight or span.leg.slope_and_bend(span.leg.end))
    )


def pointwise_dissipation(
    contact: Contact, modulus: float, spans: Sequence[Span], x: Array
) -> Split:
    """Friction work of the spans at |x| = `x` (k,): shape (k,) [energy per area].

    While Q grows at constant P it is f p(x) s(x), with the slip s = (f A/pi) [S(x, P) - S(x, P_c)]
    of `HertzContact.slip_integral`.

    >>> from scenes.segments import straight_segments
    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.history import march
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> spans, _ = march(
    ...     None, straight_segments([(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 1.0, 0.3)]), 0.5, 0.0
    ... )  # P_c = 0.4
    >>> slip = (
    ...     0.5 * 2 / math.pi * (contact.slip_integral(1.0, 1.0) - contact.slip_integral(1.0, 0.4))
    ... )
    >>> work = pointwise_dissipation(contact, 1.0, spans, np.array([0.3, 1.0])).total  # 0.3 sticks
    >>> (
    ...     float(work[0]),
    ...     round(float(work[1]), 12),
    ...     round(float(0.5 * contact.pressure(1.0, 1.0) * slip), 12),
    ... )
    (0.0, 0.008438314611, 0.008438314611)
    """
    edge = contact.load(x)
    parts = [
        (span, *slip_times(span, edge))
        for span in spans
        if span.direction and span.active is not None
    ]

    def work(span: Span, which: Indices, low: Array, high: Array, rule: Rule) -> Array:
        times, weights = rule(low, high)
        at, load = x[which, None], span.leg.loads(times)[0]
        front = load - span.slipped(times)
        ratio = contact.arccosh_ratio(
            at, np.maximum(edge[which, None] - front, 0.0), contact.advance(front)
        )
        return np.asarray(
            np.sum(weights * _growth(span, times) * contact.pressure(at, load) * ratio, axis=-1)
        )

    return _over_spans(contact, modulus, parts, len(x), work)


def slip_times(span: Span, edge_load: Array) -> tuple[Array, Array]:
    """When, within a span, points are in contact and outside the front; end <= begin if never."""
    assert span.active is not None
    leg, what, first, last = span.leg, level(span.direction, span.friction), span.begin, span.end
    top, bottom = span.active.top, span.active.bottom
    front = level_on(span.active, span.direction, span.friction, np.clip(edge_load, bottom, top))
    amount = front - float(change_from(span.active.anchor, leg, what, first.time))
    begin = leg.time_of(what, amount, first.time, last.time)
    begin = np.where(edge_load >= top, first.time, np.where(edge_load <= bottom, last.time, begin))
    meets = leg.time_of(NORMAL_LOAD, edge_load - first.normal, first.time, last.time)
    # Of the change itself: where P hardly moves, the last digits of both loads may say that it
    # falls while it grows.
    growth = float(leg.change_of(NORMAL_LOAD, last.time, first.time))
    if growth >= LEAST:
        return np.maximum(begin, np.where(edge_load >= last.normal, last.time, meets)), np.full(
            begin.shape, last.time
        )
    inside = edge_load < max(first.normal, last.normal)
    end = meets if growth <= -LEAST else np.full(begin.shape, last.time)
    return begin, np.where(inside, end, begin)


def closed_integral(contact: Contact, modulus: float, spans: Sequence[Span]) -> LoopWork:
    """Closed integral of Q dU over the spans of a steady cycle [energy per unit thickness], the
    area of the hysteresis loop.

    And what the last digits of the tangential displacement U may have left in it. Written as -int U
    dQ, of which any multiple of the integral of Q dQ, which vanishes, may be taken away.

    Of Q between -k f P and k f P at constant P: (2 A f^2 P^2/pi) [(1 - k) ln(1 - k) + k - k^2/2].

    >>> from scenes.segments import straight_segments
    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.history import march
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> rows = [
    ...     (0.0, 0.0, 0.0),
    ...     (1.0, 1.0, 0.0),
    ...     (2.0, 1.0, 0.3),
    ...     (3.0, 1.0, -0.3),
    ...     (4.0, 1.0, 0.3),
    ... ]  # k = 0.6
    >>> spans, _ = march(None, straight_segments(rows), 0.5, 0.0)
    >>> closed = 4 * 0.5**2 / math.pi * (0.4 * math.log(0.4) + 0.6 - 0.18)
    >>> (
    ...     round(
    ...         closed_integral(contact, 1.0, [span for span in spans if span.begin.time >= 2.0])[
    ...             0
    ...         ],
    ...         12,
    ...     ),
    ...     round(closed, 12),
    ... )
    (0.017024392768, 0.017024392768)
    """
    largest = max(max(span.begin.normal, span.end.normal) for span in spans)
    contact = _flat_at(contact, largest)
    integrals = Integrals(contact, np.zeros(1), "shift")
    # U is a sum of logarithms times loads up to f P, however little of it changes: its last digits,
    # all along Q.
    size = 2 * abs(float(contact.log_distance(largest)))
    ways = [span.leg.loads(np.linspace(span.begin.time, span.end.time, 5))[1] for span in spans]
    doubt = (
        _DIGITS_OF_SHIFT
        * spans[0].friction
        * size
        * sum(float(np.sum(np.abs(np.diff(way)))) for way in ways)
    )

    def work(span: Span, _: Indices, low: Array, high: Array, rule: Rule) -> Array:
        times, weights = rule(low, high)
        shift = integrals.over(take([(span, times.ravel())]))[:, 0].reshape(times.shape)
        return -np.sum(shift * span.leg.rate_of(Combination(0.0, 1.0), times) * weights, axis=1)

    total = _over_spans(contact, modulus, [_whole(span) for span in spans], 1, work).total[0]
    return LoopWork(float(total), 2 / (math.pi * modulus) * doubt)


def _flat_at(contact: Contact, largest: float) -> Contact:
    """The contact with the datum of U set so that ln(2 L/a) is nothing where the contact is
    largest.

    That keeps the digits of a closed integral where the logarithm hardly varies, as for a face that
    is nearly all flat.
    """
    found = replace(contact, datum_length=float(contact.half_width(largest)) / 2)
    return replace(found, rigid="loop") if isinstance(found, TiltedProfile) else found


Values = Callable[[Indices, Array, Array], Array]
"""Something along records number (n,) at P and P - P_c (n, k): (n, k)."""


def _means(contact: Contact, records: Records, values: Values) -> tuple[Array, int]:
    """Mean of `values` along each record, (m,), and how many nodes it took.

    P and P_c are linear along a record. The integrand is singular where either would be 0, beyond
    an end, if they went on, and where it would be at the corner below: as d^(3/2) only, which nodes
    that crowd to both ends resolve.
    """
    parts = _split(contact, records)
    corners, tiny = contact.break_loads, np.finfo(float).tiny
    shares = []  # how much of the way to 0, and to the corner below, a part takes
    for base in (np.empty(0), corners):
        share = np.zeros(len(parts.row))
        for pair in (
            (parts.load, parts.load_after),
            (parts.load - parts.slipped, parts.load_after - parts.slipped_after),
        ):
            low, high = np.minimum(*pair), np.maximum(*pair)
            below = np.append(0.0, base)[np.searchsorted(base, (low + high) / 2)]
            share = np.maximum(
                share, 1 - np.maximum(low - below, 0.0) / np.maximum(high - below, tiny)
            )
        shares.append(share)
    which = np.searchsorted(_SHARES, shares[0])
    which[(which < len(_SHARES)) & (shares[1] > np.maximum(shares[0], _SHARES[0]))] = (
        len(_SHARES) + 1
    )
    result, nodes = np.zeros(len(records.row)), 0
    for number, (part, weight) in enumerate(
        [*(gauss(count) for count in _COUNTS), (ROOTS.up, ROOTS.share), crowded(0.0, 1.0)]
    ):
        some = parts.take(np.flatnonzero(which == number))
        load = some.load[:, None] + (some.load_after - some.load)[:, None] * part
        slipped = some.slipped[:, None] + (some.slipped_after - some.slipped)[:, None] * part
        means = some.until * np.sum(
            weight * values(some.row, load, np.clip(slipped, 0.0, load)), axis=1
        )
        result += np.bincount(some.row, means, len(result))
        nodes += load.size
    return result, nodes


def _split(contact: Contact, records: Records) -> Records:
    """The records in parts between which neither P nor P_c passes a load at which a(P) is not
    smooth.

    `row` of a part is the number of its record, `until` its share of it. Loads are those of corners
    and, where P may hardly grow anywhere, of half-widths so close that a(P) is smooth in between.
    """
    cuts = contact.break_loads
    if contact.bends_anywhere and len(records.row):
        largest = contact.half_width(
            max(float(np.max(records.load)), float(np.max(records.load_after)))
        )
        cuts = np.append(cuts, contact.load(largest * _LADDER))
    low = np.zeros((len(records.row), 1 + 2 * len(cuts)))
    fronts = records.load - records.slipped, records.load_after - records.slipped_after
    for k, (begin, end) in enumerate(((records.load, records.load_after), fronts)):
        growth = np.where(end != begin, end - begin, np.inf)[:, None]
        low[:, 1 + k * len(cuts) : 1 + (k + 1) * len(cuts)] = np.clip(
            (cuts - begin[:, None]) / growth, 0.0, 1.0
        )
    low.sort(axis=1)
    high = np.append(low[:, 1:], np.ones((len(low), 1)), axis=1)
    row, number = np.nonzero(high > low)
    first, last = low[row, number], high[row, number]
    load, fall = records.load[row], (records.load_after - records.load)[row]
    slid, slip = records.slipped[row], (records.slipped_after - records.slipped)[row]
    ends = (load + first * fall, load + last * fall, slid + first * slip, slid + last * slip)
    return Records(
        records.direction[row], *ends, records.rise[row] * (last - first), last - first, row
    )


def slip_work(contact: Contact, records: Records) -> tuple[Array, int]:
    """int Lam dw of each record of slip, (m,) [force^2 per thickness^2], and how many nodes it
    took.
    """
    means, nodes = _means(
        contact, records, lambda _, load, slipped: contact.dissipation_kernel(load, slipped)
    )
    return records.rise * means, nodes


def work_error(contact: Contact, records: Records) -> float:
    """Error of the sum of `slip_work` from above, by a sample of records; 0 for closed forms
    [force^2 per thickness^2].
    """
    if contact.closed_form or not len(records.row):
        return 0.0
    some = records.take(np.unique(np.linspace(0, len(records.row) - 1, _SAMPLE).astype(int)))
    load, slipped = (
        np.append(some.load, some.load_after),
        np.append(some.slipped, some.slipped_after),
    )
    left = contact.quadrature_error(
        "dissipation_kernel", load, slipped
    ) + _RULE * contact.dissipation_kernel(load, slipped)
    if not np.all(np.isfinite(left)):
        raise NotFoundError(
            "the error of a slip area is not a number: neither is the dissipation of these rows"
        )
    return float(np.max(left, initial=0.0) * np.sum(records.rise))


def density_of_records(contact: Contact, records: Records, x: Array) -> Array:
    """int p arccosh(|x|/c) dw of all records of slip at |x| = `x` (k,): shape (k,) [stress * force
    per thickness].
    """
    edge, total, parts = contact.load(x), np.zeros(len(x)), _split(contact, records)
    load, growth = parts.load, parts.load_after - parts.load
    front, drop = load - parts.slipped, parts.slipped_after - parts.slipped - growth
    for first in range(0, len(load), max(_CHUNK // len(x), 1)):
        # Between which shares of a part points of edge load P_x are in contact and outside the
        # front.
        some = slice(first, first + max(_CHUNK // len(x), 1))
        start, way, c, fall = (column[some, None] for column in (load, growth, front, drop))
        begin = np.where(
            edge >= c,
            0.0,
            np.where(fall > 0, np.clip((c - edge) / np.where(fall > 0, fall, 1.0), 0.0, 1.0), 1.0),
        )
        meets = np.clip((edge - start) / np.where(way != 0, way, 1.0), 0.0, 1.0)
        end = np.where(edge < np.maximum(start, start + way), np.where(way < 0, meets, 1.0), 0.0)
        begin = np.where(way > 0, np.maximum(begin, meets), begin)
        number, point = np.nonzero(end > begin)
        for j in range(0, len(number), _CHUNK // NODES):
            n, i = number[j : j + _CHUNK // NODES], point[j : j + _CHUNK // NODES]
            at, weight = graded(begin[n, i], end[n, i])
            p, p_c = start[n] + way[n] * at, np.maximum(c[n] - fall[n] * at, 0.0)
            ratio = contact.arccosh_ratio(
                x[i, None], np.maximum(edge[i, None] - p_c, 0.0), contact.advance(p_c)
            )
            work = parts.rise[some][n] * np.sum(
                weight * contact.pressure(x[i, None], p) * ratio, axis=1
            )
            total += np.bincount(i, work, len(x))
    return total


class Loop:
    """Closed integral of Q dU over the records of a steady cycle, block by block, and what rounding
    may have left in it.

    With G = int_0^P ln(2 L/a) d eta and the slope m of the line that a record goes through, U over
    A/pi grows along it by m times the growth of G(P_c) plus s f times that of G(P) - G(P_c).
    """

    def __init__(self, contact: Contact, modulus: float, friction: float, largest: float) -> None:
        self._contact, self._friction, self._shift, self._total, self._path = (
            _flat_at(contact, largest),
            friction,
            0.0,
            0.0,
            0.0,
        )
        self._unit, self._size = (
            2 / (math.pi * modulus),
            2 * abs(float(self._contact.log_distance(largest))),
        )

    def add(self, block: StepBlock) -> None:
        """The records of the next block."""
        contact, records = self._contact, block.records
        slope = block.line_table.slope
        limit, growth = records.direction * self._friction, records.load_after - records.load

        def moved(which: Indices, load: Array, slipped: Array) -> Array:
            whole = contact.log_distance(load)
            front = np.where(
                slipped > 0, contact.log_distance(np.maximum(load - slipped, 0.0)), whole
            )
            return slope[which, None] * front + limit[which, None] * (whole - front)

        ends = (
            np.stack([records.load, records.load_after], axis=1),
            np.stack([records.slipped, records.slipped_after], axis=1),
        )
        begin, end = moved(np.arange(len(slope)), *ends).T
        force = np.where(
            records.direction == 0,
            slope * growth,
            records.direction * (records.rise + self._friction * growth),
        )
        shift = self._shift + np.cumsum(end - begin)
        self._total -= float(np.sum(force * (shift - end + _means(contact, records, moved)[0])))
        self._path, self._shift = self._path + float(np.sum(np.abs(force))), float(shift[-1])

    @property
    def value(self) -> LoopWork:
        """The integral so far."""
        return LoopWork(
            self._unit * self._total,
            self._unit * _DIGITS_OF_SHIFT * self._friction * self._size * self._path,
        )


class LoopWork(NamedTuple):
    """Closed integral of Q dU [energy per unit thickness], and what rounding may have left in
    it.
    """

    value: float
    rounding: float


class Converged(NamedTuple):
    """Integrals (m,), and an estimate of the error of each: what the last halving changed.

    Covered down to the floor of a rule: `graded` leaves 4e-12 of a part that has a pole beside its
    end, at whatever distance.
    """

    value: Array
    error: Array


def by_halving(
    work: Callable[[Indices, Array, Array], Array],
    begin: ArrayLike,
    end: ArrayLike,
    allowed: float,
    marks: ArrayLike = (),
) -> Converged:
    """Integrals of m integrands, number k from begin[k] to end[k].

    Parameters
    ----------
    work : work(which (n,), low (n,), high (n,)) gives the integral of integrand which[k] from
    low[k] to high[k], (n,), by one rule begin, end : (m,)
    allowed : the change at which a part has converged, `CONVERGED` of their size where rounding
        leaves as much. A part of 2^-17 of its range, or one that is not finite, is left as it is,
        and so are too many at once; the error shows that.
    marks : (j,) ascending, where a part is cut rather than in its middle: the integrands are not
        smooth there

    >>> def midpoint(which, low, high):
    ...     return (high - low) * (low + high) / 2
    >>> by_halving(midpoint, [0.0, 1.0], [2.0, 3.0], CONVERGED).value.tolist()
    [2.0, 4.0]
    """
    low, high, cuts = (
        np.array(begin, dtype=float),
        np.array(end, dtype=float),
        np.append(marks, np.inf),
    )
    which, depth = np.arange(len(low)), np.zeros(len(low), dtype=int)
    value, error = np.zeros(len(low)), np.zeros(len(low))
    rough = work(which, low, high)
    while len(which):
        middle = (low + high) / 2
        # The mark next above the middle, else the one below it, else the middle itself: parts next
        # to nothing would change nothing.
        number, margin = np.searchsorted(cuts, middle), (high - low) / 16
        for nearest in (cuts[number - 1], cuts[number]):
            inside = (nearest > low + margin) & (nearest < high - margin)
            middle, depth = np.where(inside, nearest, middle), np.where(inside, -1, depth)
        left, right = np.split(work(np.tile(which, 2), np.r_[low, middle], np.r_[middle, high]), 2)
        change = np.abs(left + right - rough)
        done = (
            (change <= allowed)
            | ~np.isfinite(change)
            | (depth == _HALVINGS)
            | (len(which) > _MOST * len(value) + _FEW)
        )
        np.add.at(value, which[done], (left + right)[done])
        np.add.at(error, which[done], change[done])
        on = ~done
        low, high = np.r_[low[on], middle[on]], np.r_[middle[on], high[on]]
        which, rough, depth = (
            np.tile(which[on], 2),
            np.r_[left[on], right[on]],
            np.tile(depth[on] + 1, 2),
        )
    return Converged(value, error)
