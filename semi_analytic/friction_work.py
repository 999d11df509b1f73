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
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import NORMAL_LOAD, Combination, NotFoundError
from scenes.array_types import Array
from scenes.segments import LEAST
from semi_analytic.fields import Integrals
from semi_analytic.history import Span, corner_times, snapshot_of
from semi_analytic.load_series import Records, StepBlock
from semi_analytic.memory import change_from, level, level_on
from semi_analytic.profiles import Contact
from semi_analytic.quadrature import NODES, crowded, gauss, graded
from semi_analytic.tilted_profile import TiltedProfile

Indices = NDArray[np.intp]

CONVERGED = 1e-12
# How often a range is halved at most: parts of 1/131,072 of it are left as they are; and all parts
# where they are more than so many an integral and a few hundred: what is left to halve then is the
# last digits of loads along which next to nothing slips.
_HALVINGS = 17
_MOST = 64
_FEW = 256
# Share of U, as a sum of logarithms times loads, that its last digits may be off.
_DIGITS_OF_SHIFT = 5e-16
# Nodes of Gauss' rule while P and P_c change by less than a share: 3e-13 by the distance of the
# singularity. Above, graded, which takes 193: a million rows would take ten times as long. Close
# behind a corner, 24 that crowd to both ends.
_RULE = 3e-13
_SHARES = (0.05, 0.3, 0.6, 0.9)
_COUNTS = (4, 6, 12, 24)
# Records of a block that are looked at for the error of W.
_SAMPLE = 200
# Half-widths over the largest: 7 % apart a root of dP/da at 0.73 +- 0.24 i leaves 4e-14 of W, 16 %
# apart 2e-11.
_LADDER = 2.0 ** -np.arange(0.1, 5.0, 0.1)
# Quadrature nodes that are held at a time.
_CHUNK = 200_000
_TINY = float(np.finfo(float).tiny)


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
    """Friction work of spans of a load path over the whole contact, its forward and reverse part
    and its error [energy per unit thickness].

    A span is a time of slip in one direction, or of full stick. From Q = 0 to k f P at constant P
    it is (A f^2 P^2/(2 pi)) [(1 - k) ln(1 - k) + k - k^2/2], A = 2/E*, E* = `modulus`.

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
    ranges = [
        _whole_span(span) for span in spans if span.direction and span.sticking_piece is not None
    ]

    def work(span_range: SpanRanges, rule: QuadratureRule) -> Array:
        span = span_range.span
        times, weights = rule(span_range.begin, span_range.end)
        load, _tangential = span.leg.loads(times)
        kernel = contact.dissipation_kernel(load, span.slipped_at(times, load))
        return np.asarray(np.sum(weights * _growth(span, times) * kernel, axis=-1))

    split = _over_spans(contact, modulus, ranges, 1, _span_by_span(work))
    return Split(split.forward[0], split.reverse[0], split.error[0])


QuadratureRule = Callable[[ArrayLike, ArrayLike], tuple[Array, Array]]
"""Nodes and weights between ends (n,): (n, nodes) each."""


class SpanRanges(NamedTuple):
    """A span, the numbers of the integrals along it, and when each begins and ends, (n,) each."""

    span: Span
    number: Indices
    begin: Array
    end: Array


def _whole_span(span: Span) -> SpanRanges:
    begin = np.array([span.begin.time])
    return SpanRanges(span, np.zeros(1, dtype=int), begin, np.array([span.end.time]))


IntegralsAlong = Callable[[Sequence[SpanRanges], QuadratureRule], Sequence[Array]]
"""The integrals along the ranges of each of some spans, by one rule: (n,) for each span."""


def _span_by_span(integral_along: Callable[[SpanRanges, QuadratureRule], Array]) -> IntegralsAlong:
    """Integrals along spans, one span after the other."""

    def integrals_along(ranges: Sequence[SpanRanges], rule: QuadratureRule) -> list[Array]:
        return [integral_along(span_range, rule) for span_range in ranges]

    return integrals_along


def _over_spans(
    contact: Contact,
    modulus: float,
    ranges: Sequence[SpanRanges],
    n_integrals: int,
    integrals_along: IntegralsAlong,
) -> Split:
    """Sums of integrals over the time of slip, times A/pi, of forward and of reverse slip, and
    their error; A = 2/E*.

    The load path is given in spans, times of slip in one direction. A span is integrated by one
    rule. Where edges of contact or stick move unevenly, or pass corners of the profile, it is
    halved until the sum no longer changes.

    Parameters
    ----------
    modulus
        E* [stress]
    ranges
        the spans, with begin and end of each integral that has a part in them
    n_integrals
        number of integrals, such as one for each point
    integrals_along
        the integrals along some of these ranges, or parts of them

    Returns
    -------
    Split
        forward, reverse and the error of both, (n_integrals,) each
    """
    cuts_of_spans = [corner_times(contact, span_range.span) for span_range in ranges]
    is_rough = np.array(
        [
            len(cuts) > 0 or uneven(contact, span_range.span)
            for cuts, span_range in zip(cuts_of_spans, ranges, strict=True)
        ],
        dtype=bool,
    )
    values = np.zeros((len(ranges), n_integrals))
    errors = np.zeros((len(ranges), n_integrals))
    for rule, is_of_rule in ((graded, ~is_rough), (crowded, is_rough)):
        spans_of_rule = [k for k in np.flatnonzero(is_of_rule).tolist() if len(ranges[k].number)]
        if spans_of_rule:
            integrals = integrals_along([ranges[k] for k in spans_of_rule], rule)
            for k, integrals_of_span in zip(spans_of_rule, integrals, strict=True):
                values[k, ranges[k].number] = integrals_of_span
    rough_spans = [k for k in np.flatnonzero(is_rough).tolist() if len(ranges[k].number)]
    if rough_spans:
        # One size for all: a short span by itself may be all round-off, and would never converge
        # to its own.
        largest_sum = float(np.max(np.abs(np.sum(values, axis=0))))
        size_of_spans = np.maximum(largest_sum, np.max(np.abs(values), axis=1))
        # 1e-14 across corners, for many small kinks may hide from one halving.
        has_cuts = np.array([len(cuts) > 0 for cuts in cuts_of_spans])
        error_share = np.where(has_cuts, min(CONVERGED, 25 * contact.noise), CONVERGED)
        allowed_errors = error_share * size_of_spans
        rough_ranges = [ranges[k] for k in rough_spans]
        span_number = np.repeat(
            rough_spans, [len(span_range.number) for span_range in rough_ranges]
        )
        number_of_integral = np.concatenate([span_range.number for span_range in rough_ranges])
        values[span_number, number_of_integral], errors[span_number, number_of_integral] = (
            by_halving(
                partial(
                    _integrals_of_parts, ranges, integrals_along, span_number, number_of_integral
                ),
                np.concatenate([span_range.begin for span_range in rough_ranges]),
                np.concatenate([span_range.end for span_range in rough_ranges]),
                allowed_errors[span_number],
                np.unique(np.concatenate([cuts_of_spans[k] for k in rough_spans])),
                first_estimate=values[span_number, number_of_integral],
            )
        )
    is_forward = np.array([span_range.span.direction > 0 for span_range in ranges], dtype=bool)
    unit_compliance = 2 / (math.pi * modulus)
    return Split(
        forward=unit_compliance * np.sum(values[is_forward], axis=0),
        reverse=unit_compliance * np.sum(values[~is_forward], axis=0),
        error=unit_compliance * np.sum(errors, axis=0),
    )


def _integrals_of_parts(
    ranges: Sequence[SpanRanges],
    integrals_along: IntegralsAlong,
    span_number: Indices,
    number_of_integral: Indices,
    which: Indices,
    begins: Array,
    ends: Array,
) -> Array:
    """Integrals along parts of spans, from `begins` to `ends` in time, (n,) each.

    Parameters
    ----------
    ranges
        the spans, times of slip in one direction
    integrals_along
        integrates along parts of several spans at once
    span_number, number_of_integral
        (m,) span and number in it of each integral that is cut into parts
    which
        (n,) of which of these m integrals each part is
    """
    spans_of_parts = np.unique(span_number[which]).tolist()
    places = [np.flatnonzero(span_number[which] == k) for k in spans_of_parts]
    parts = [
        SpanRanges(
            ranges[k].span,
            number_of_integral[which[places_of_span]],
            begins[places_of_span],
            ends[places_of_span],
        )
        for k, places_of_span in zip(spans_of_parts, places, strict=True)
    ]
    integrals = np.zeros(len(which))
    for places_of_span, integrals_of_span in zip(
        places, integrals_along(parts, crowded), strict=True
    ):
        integrals[places_of_span] = integrals_of_span
    return integrals


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
    if span.leg.ellipse is not None:
        return False
    if span.sticking_piece is not None and span.sticking_piece.arc is not None:
        return True
    return not (span.leg.is_straight or span.leg.slope_and_bend(span.leg.end))


def pointwise_dissipation(
    contact: Contact, modulus: float, spans: Sequence[Span], x: Array
) -> Split:
    """Friction work per area W(x) of spans of a load path at |x| = `x` (k,): its forward and
    reverse part and its error, (k,) each [energy per area].

    A span is a time of slip in one direction, or of full stick. While Q grows at constant P, W(x)
    is f p(x) s(x) with the slip s = (f A/pi) [S(x, P) - S(x, P_c)]. S(x, P) is the integral of
    arccosh(|x|/a) over the loads up to P, P_c the load at the stick edge, A = 2/E*, E* = `modulus`.

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
    edge_loads = contact.load(x)
    slip_spans = [span for span in spans if span.direction and span.sticking_piece is not None]
    ranges = []
    for span in slip_spans:
        begin_time, end_time = slip_times(span, edge_loads)
        points = np.flatnonzero(end_time > begin_time)
        ranges.append(SpanRanges(span, points, begin_time[points], end_time[points]))

    def work(span_range: SpanRanges, rule: QuadratureRule) -> Array:
        span = span_range.span
        times, weights = rule(span_range.begin, span_range.end)
        places = x[span_range.number, None]
        load, _tangential = span.leg.loads(times)
        stick_edge_load = load - span.slipped_at(times, load)
        excess = np.maximum(edge_loads[span_range.number, None] - stick_edge_load, 0.0)
        ratio = contact.arccosh_ratio(places, excess, contact.advance(stick_edge_load))
        works = weights * _growth(span, times) * contact.pressure(places, load) * ratio
        return np.asarray(np.sum(works, axis=-1))

    return _over_spans(contact, modulus, ranges, len(x), _span_by_span(work))


def slip_times(span: Span, edge_load: Array) -> tuple[Array, Array]:
    """When, within a span of slip in one direction, points begin and end to slip, (k,) each; the
    end is not after the begin where a point never does.

    A point slips while it is in contact and outside the stick zone. `edge_load` (k,) is the load at
    which the edge of contact is at the point: it begins where the stick edge, or the contact,
    reaches the point.
    """
    assert span.sticking_piece is not None
    leg = span.leg
    slip_level = level(span.direction, span.friction)
    begin_instant = span.begin
    end_instant = span.end
    piece_top = span.sticking_piece.top
    piece_bottom = span.sticking_piece.bottom
    load_on_piece = np.clip(edge_load, piece_bottom, piece_top)
    level_at_point = level_on(span.sticking_piece, span.direction, span.friction, load_on_piece)
    level_rise = level_at_point - float(
        change_from(span.sticking_piece.anchor, leg, slip_level, begin_instant.time)
    )
    time_of_stick_edge = leg.time_of(slip_level, level_rise, begin_instant.time, end_instant.time)
    time_of_stick_edge = np.where(edge_load <= piece_bottom, end_instant.time, time_of_stick_edge)
    begin_time = np.where(edge_load >= piece_top, begin_instant.time, time_of_stick_edge)
    time_of_contact_edge = leg.time_of(
        NORMAL_LOAD, edge_load - begin_instant.normal, begin_instant.time, end_instant.time
    )
    span_end = np.full(begin_time.shape, end_instant.time)
    # Of the change itself: where P hardly moves, the last digits of both loads may say that it
    # falls while it grows.
    load_growth = float(leg.change_of(NORMAL_LOAD, end_instant.time, begin_instant.time))
    if load_growth >= LEAST:
        time_of_touch = np.where(
            edge_load >= end_instant.normal, end_instant.time, time_of_contact_edge
        )
        return np.maximum(begin_time, time_of_touch), span_end
    is_met = edge_load < max(begin_instant.normal, end_instant.normal)
    end_time = time_of_contact_edge if load_growth <= -LEAST else span_end
    return begin_time, np.where(is_met, end_time, begin_time)


def closed_integral(contact: Contact, modulus: float, spans: Sequence[Span]) -> LoopWork:
    """Work of the tangential load in a steady cycle, the closed integral of Q dU over its spans
    [energy per unit thickness]; and what the last digits of the displacement U may leave in it.

    The integral is the area of the hysteresis loop, and equals the friction work. It is taken as
    -int U dQ, from which any multiple of the closed integral of Q dQ, which is 0, may be
    subtracted. A span is a time in full stick or with slip in one direction.

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
    largest_load = max(max(span.begin.normal, span.end.normal) for span in spans)
    contact = _flat_at(contact, largest_load)
    integrals = Integrals(contact, np.zeros(1), "shift")
    # U is a sum of logarithms times loads up to f P, however little of it changes: its last digits,
    # all along Q.
    displacement_size = 2 * abs(float(contact.log_distance(largest_load)))
    path_of_force = 0.0
    for span in spans:
        _normal, force = span.leg.loads(np.linspace(span.begin.time, span.end.time, 5))
        path_of_force += float(np.sum(np.abs(np.diff(force))))
    roundoff = _DIGITS_OF_SHIFT * spans[0].friction * displacement_size * path_of_force

    def work(ranges: Sequence[SpanRanges], rule: QuadratureRule) -> list[Array]:
        """-int U dQ over the time of all ranges at once, (n,) for each range.

        U is evaluated at the quadrature nodes of all of them together, over A/pi.
        """
        nodes = [rule(span_range.begin, span_range.end) for span_range in ranges]
        times_of_spans = [
            (span_range.span, times.ravel())
            for span_range, (times, _) in zip(ranges, nodes, strict=True)
        ]
        displacement = integrals.over(snapshot_of(times_of_spans))[:, 0]
        ends = np.cumsum([len(times) for _, times in times_of_spans])
        works_of_ranges = []
        for span_range, (times, weights), end_of_range in zip(
            ranges, nodes, ends.tolist(), strict=True
        ):
            displacement_of_span = displacement[end_of_range - times.size : end_of_range].reshape(
                times.shape
            )
            force_rate = span_range.span.leg.rate_of(Combination(0.0, 1.0), times)
            works_of_ranges.append(-np.sum(displacement_of_span * force_rate * weights, axis=1))
        return works_of_ranges

    ranges = [_whole_span(span) for span in spans]
    total = _over_spans(contact, modulus, ranges, 1, work).total[0]
    return LoopWork(float(total), 2 / (math.pi * modulus) * roundoff)


def _flat_at(contact: Contact, largest_load: float) -> Contact:
    """The contact with the datum of the displacement U moved, so that its logarithm ln(2 L/a) is 0
    where the contact is largest.

    That keeps the digits of a closed integral of U where the logarithm hardly varies, as for a face
    that is nearly all flat. `largest_load` is P there.
    """
    moved_contact = replace(contact, datum_length=float(contact.half_width(largest_load)) / 2)
    return (
        replace(moved_contact, rigid="loop")
        if isinstance(moved_contact, TiltedProfile)
        else moved_contact
    )


Values = Callable[[Indices, Array, Array], Array]
"""Something along records number (n,) at P and P - P_c (n, k): (n, k)."""


def _means(contact: Contact, records: Records, values: Values) -> tuple[Array, int]:
    """Mean of a function of the loads along each record of slip, (m,), and how many quadrature
    nodes it took.

    A record is a part of a load step in which P and P_c, the load at the stick edge, change
    linearly. The integrand is singular where either would be 0 beyond an end. At the corner of the
    profile below it goes as d^(3/2) only, which nodes that crowd to both ends resolve.

    Parameters
    ----------
    values
        the function of (record numbers, P, P - P_c) at nodes
    """
    smooth_parts = _split(contact, records)
    rule_of_part = _rule_numbers(
        _share_of_way(smooth_parts, np.empty(0)), _share_of_way(smooth_parts, contact.break_loads)
    )
    means = np.zeros(len(records.row))
    node_count = 0
    for rule_number, (rule, _) in enumerate(_RULES):
        share_of_part, weights = rule(0.0, 1.0)
        parts_of_rule = smooth_parts.take(np.flatnonzero(rule_of_part == rule_number))
        load_growth = parts_of_rule.load_after - parts_of_rule.load
        slip_growth = parts_of_rule.slipped_after - parts_of_rule.slipped
        load = parts_of_rule.load[:, None] + load_growth[:, None] * share_of_part
        slipped_load = parts_of_rule.slipped[:, None] + slip_growth[:, None] * share_of_part
        values_at_nodes = values(parts_of_rule.row, load, np.clip(slipped_load, 0.0, load))
        means_of_parts = parts_of_rule.until * np.sum(weights * values_at_nodes, axis=1)
        means += np.bincount(parts_of_rule.row, means_of_parts, len(means))
        node_count += load.size
    return means, node_count


def _gauss_rule(count: int) -> QuadratureRule:
    """Gauss' rule of `count` nodes."""
    nodes, weights = gauss(count)

    def rule(begin: ArrayLike, end: ArrayLike) -> tuple[Array, Array]:
        begin_column = np.asarray(begin, dtype=float)[..., None]
        length = np.asarray(end, dtype=float)[..., None] - begin_column
        return begin_column + length * nodes, length * weights

    return rule


_RULES: tuple[tuple[QuadratureRule, int], ...] = (
    *((_gauss_rule(count), count) for count in _COUNTS),
    (graded, NODES),
    (crowded, len(crowded(0.0, 1.0)[0])),
)
"""Rules for records of slip and their numbers of nodes."""


def _rule_numbers(share_to_singularity: Array, share_to_corner: Array) -> Indices:
    """Number of the quadrature rule for each of some integrands (m,): more nodes the nearer a
    singularity, crowded nodes next to a corner of the profile.

    A share is the part of the way to the singularity, or to the corner below, that the integrand's
    range covers.
    """
    rule_number = np.searchsorted(_SHARES, share_to_singularity)
    is_beside_corner = share_to_corner > np.maximum(share_to_singularity, _SHARES[0])
    rule_number[(rule_number < len(_SHARES)) & is_beside_corner] = len(_SHARES) + 1
    return rule_number


def _share_of_way(parts: Records, corners: Array) -> Array:
    """How near each part of slip records comes to a singularity: the largest share of the way to 0,
    or to the corner of the profile below, that P or P_c goes, (m,).

    P_c is the load at the stick edge; `corners` are loads at which the contact edge is at a corner.
    """
    largest_share = np.zeros(len(parts.row))
    edge_load = parts.load - parts.slipped
    edge_load_after = parts.load_after - parts.slipped_after
    for load_at_begin, load_at_end in (
        (parts.load, parts.load_after),
        (edge_load, edge_load_after),
    ):
        least_load = np.minimum(load_at_begin, load_at_end)
        largest_load = np.maximum(load_at_begin, load_at_end)
        corner_below = np.append(0.0, corners)[
            np.searchsorted(corners, (least_load + largest_load) / 2)
        ]
        largest_share = np.maximum(
            largest_share, _share_to_zero(least_load - corner_below, largest_load - corner_below)
        )
    return largest_share


def _share_to_zero(begin: Array, end: Array) -> Array:
    """Share of the way to 0 that a distance goes from one end of a range to the other; 1 where it
    is 0 at one of them.
    """
    least_distance = np.maximum(np.minimum(begin, end), 0.0)
    return np.asarray(1 - least_distance / np.maximum(np.maximum(begin, end), _TINY))


def _split(contact: Contact, records: Records) -> Records:
    """Cut `records` of slip, so that along each part the half-width a(P) of `contact` is smooth at
    both P and P_c, the load at the stick edge.

    A record is a part of a load step in which P and P_c change linearly. Cuts are at the loads of
    the profile's corners. Where P may hardly grow anywhere they are also at half-widths so close
    that a(P) is smooth in between. In the parts returned `row` is the number of the record, and
    `until` the share of it.
    """
    break_loads = contact.break_loads
    if contact.bends_anywhere and len(records.row):
        largest_load = max(float(np.max(records.load)), float(np.max(records.load_after)))
        largest_half_width = contact.half_width(largest_load)
        break_loads = np.append(break_loads, contact.load(largest_half_width * _LADDER))
    stick_edge_load = records.load - records.slipped
    stick_edge_load_after = records.load_after - records.slipped_after
    shares_at_breaks = [np.zeros((len(records.row), 1))]
    for load_at_begin, load_at_end in (
        (records.load, records.load_after),
        (stick_edge_load, stick_edge_load_after),
    ):
        load_change = np.where(load_at_end != load_at_begin, load_at_end - load_at_begin, np.inf)[
            :, None
        ]
        shares_at_breaks.append(
            np.clip((break_loads - load_at_begin[:, None]) / load_change, 0.0, 1.0)
        )
    share_at_begin = np.concatenate(shares_at_breaks, axis=1)
    share_at_begin.sort(axis=1)
    share_at_end = np.append(share_at_begin[:, 1:], np.ones((len(share_at_begin), 1)), axis=1)
    record_number, cut_number = np.nonzero(share_at_end > share_at_begin)
    begin_share = share_at_begin[record_number, cut_number]
    end_share = share_at_end[record_number, cut_number]
    load = records.load[record_number]
    load_growth = (records.load_after - records.load)[record_number]
    slipped = records.slipped[record_number]
    slip_growth = (records.slipped_after - records.slipped)[record_number]
    return Records(
        direction=records.direction[record_number],
        load=load + begin_share * load_growth,
        load_after=load + end_share * load_growth,
        slipped=slipped + begin_share * slip_growth,
        slipped_after=slipped + end_share * slip_growth,
        rise=records.rise[record_number] * (end_share - begin_share),
        until=end_share - begin_share,
        row=record_number,
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
    """Estimated error of the sum of friction work over slip records [force^2 per thickness^2]; 0
    for contacts with closed forms.

    It is the largest error of the kernel int ln(a/c) d eta and of the quadrature rule in a sample
    of records, times the growth of slip force over f of all.

    Raises
    ------
    NotFoundError
        Where the error is not a number.
    """
    if contact.closed_form or not len(records.row):
        return 0.0
    numbers = np.unique(np.linspace(0, len(records.row) - 1, _SAMPLE).astype(int))
    sample = records.take(numbers)
    load = np.append(sample.load, sample.load_after)
    slipped = np.append(sample.slipped, sample.slipped_after)
    error_of_kernel = contact.quadrature_error("dissipation_kernel", load, slipped)
    error_of_rule = _RULE * contact.dissipation_kernel(load, slipped)
    error_of_sample = error_of_kernel + error_of_rule
    if not np.all(np.isfinite(error_of_sample)):
        raise NotFoundError(
            "the error of a slip area is not a number: neither is the dissipation of these rows"
        )
    return float(np.max(error_of_sample, initial=0.0) * np.sum(records.rise))


def density_of_records(contact: Contact, records: Records, x: Array) -> Array:
    """Friction work per area over f A/pi of all records of slip at |x| = `x` (k,): the sum of int p
    arccosh(|x|/c) dw, (k,) [stress times force per thickness].

    A record is a part of a load step with slip. w is +-Q - f P, which grows in slip, p the pressure
    at x and c the stick half-width.
    """
    density = np.zeros(len(x))
    parts = _split(contact, records)
    parts_at_once = max(_CHUNK // len(x), 1)
    for first_part in range(0, len(parts.load), parts_at_once):
        chunk = parts.take(slice(first_part, first_part + parts_at_once))
        density += _density_of_parts(contact, chunk, x)
    return density


def _density_of_parts(contact: Contact, parts: Records, x: Array) -> Array:
    """Friction work per area over f A/pi of parts of slip records between corners of the profile,
    at |x| = `x` (k,): the sum of int p arccosh(|x|/c) dw [stress times force per thickness].

    w is +-Q - f P, which grows in slip, p the pressure at x and c the stick half-width. p has a
    root where P = P_x, the load at which the edge of contact is at x; the arccosh has one where P_c
    = P_x, and a logarithm where P_c = 0. A pair of part and point takes as many nodes as the
    nearest of these needs.
    """
    edge_loads = contact.load(x)
    load = parts.load[:, None]
    load_growth = (parts.load_after - parts.load)[:, None]
    stick_edge_load = load - parts.slipped[:, None]
    stick_edge_drop = (parts.slipped_after - parts.slipped)[:, None] - load_growth
    begin_shares, end_shares = _shares_in_slip(
        load, load_growth, stick_edge_load, stick_edge_drop, edge_loads
    )
    part_number, point = np.nonzero(end_shares > begin_shares)
    begin_share = begin_shares[part_number, point][:, None]
    end_share = end_shares[part_number, point][:, None]
    places = x[point, None]
    load_at_place = edge_loads[point, None]

    def loads_at(pairs: Indices, shares_at_nodes: Array) -> tuple[Array, Array]:
        """P and P_c at shares of the part (n, m) for pairs (n,)."""
        numbers = part_number[pairs]
        stick_loads = stick_edge_load[numbers] - stick_edge_drop[numbers] * shares_at_nodes
        return load[numbers] + load_growth[numbers] * shares_at_nodes, np.maximum(stick_loads, 0.0)

    all_pairs = np.arange(len(part_number))
    load_at_begin, stick_load_at_begin = loads_at(all_pairs, begin_share)
    load_at_end, stick_load_at_end = loads_at(all_pairs, end_share)
    share_to_singularity = np.max(
        [
            _share_to_zero(load_at_begin - load_at_place, load_at_end - load_at_place),
            _share_to_zero(load_at_place - stick_load_at_begin, load_at_place - stick_load_at_end),
            _share_to_zero(stick_load_at_begin, stick_load_at_end),
        ],
        axis=0,
    )[:, 0]
    share_to_corner = _share_of_way(parts, contact.break_loads)[part_number]
    rule_of_pair = _rule_numbers(share_to_singularity, share_to_corner)
    density = np.zeros(len(x))
    for rule_number, (rule, n_nodes) in enumerate(_RULES):
        pairs_of_rule = np.flatnonzero(rule_of_pair == rule_number)
        for j in range(0, len(pairs_of_rule), _CHUNK // n_nodes):
            pairs = pairs_of_rule[j : j + _CHUNK // n_nodes]
            shares_at_nodes, weights = rule(begin_share[pairs, 0], end_share[pairs, 0])
            load_at_nodes, stick_load = loads_at(pairs, shares_at_nodes)
            excess = np.maximum(load_at_place[pairs] - stick_load, 0.0)
            ratio = contact.arccosh_ratio(places[pairs], excess, contact.advance(stick_load))
            values_at_nodes = weights * contact.pressure(places[pairs], load_at_nodes) * ratio
            work = parts.rise[part_number[pairs]] * np.sum(values_at_nodes, axis=1)
            density += np.bincount(point[pairs], work, len(x))
    return density


def _shares_in_slip(
    load: Array,
    load_growth: Array,
    stick_edge_load: Array,
    stick_edge_drop: Array,
    edge_load: Array,
) -> tuple[Array, Array]:
    """Between which shares of a part of a load step points slip, (n, k) each: while they are in
    contact and outside the stick zone.

    Parameters
    ----------
    load, load_growth
        (n, 1) P at the begin of each part, and its change
    stick_edge_load, stick_edge_drop
        (n, 1) P_c, the load at the stick edge, at the begin, and how much it falls
    edge_load
        (k,) load at which the edge of contact is at a point
    """
    share_at_stick_edge = np.clip(
        (stick_edge_load - edge_load) / np.where(stick_edge_drop > 0, stick_edge_drop, 1.0),
        0.0,
        1.0,
    )
    begin_share = np.where(stick_edge_drop > 0, share_at_stick_edge, 1.0)
    begin_share = np.where(edge_load >= stick_edge_load, 0.0, begin_share)
    share_at_contact_edge = np.clip(
        (edge_load - load) / np.where(load_growth != 0, load_growth, 1.0), 0.0, 1.0
    )
    end_share = np.where(load_growth < 0, share_at_contact_edge, 1.0)
    end_share = np.where(edge_load < np.maximum(load, load + load_growth), end_share, 0.0)
    return np.where(
        load_growth > 0, np.maximum(begin_share, share_at_contact_edge), begin_share
    ), end_share


class Loop:
    """Closed integral of Q dU over the records of a steady cycle, block by block, and what rounding
    may have left in it.

    With G = int_0^P ln(2 L/a) d eta and the slope m of the line that a record goes through, U over
    A/pi grows along it by m times the growth of G(P_c) plus s f times that of G(P) - G(P_c).
    """

    def __init__(self, contact: Contact, modulus: float, friction: float, largest: float) -> None:
        self._contact = _flat_at(contact, largest)
        self._friction = friction
        self._unit = 2 / (math.pi * modulus)
        self._size = 2 * abs(float(self._contact.log_distance(largest)))
        self._shift = 0.0  # U over A/pi so far
        self._total = 0.0
        self._path_of_force = 0.0

    def add(self, block: StepBlock) -> None:
        """Add the next block of load steps to the closed integral of Q dU of a cycle.

        U, over A/pi, is summed record by record: its change over a record of slip, and its mean
        along it, from the kernel int ln(2 L/a) dP. The integral is -int U dQ.
        """
        contact = self._contact
        records = block.records
        slope = block.line_table.slope
        slope_of_slip = records.direction * self._friction
        load_growth = records.load_after - records.load

        def displacement_at(record_numbers: Indices, load: Array, slipped: Array) -> Array:
            integral_to_load = contact.log_distance(load)
            integral_to_edge_load = contact.log_distance(np.maximum(load - slipped, 0.0))
            integral_to_edge_load = np.where(slipped > 0, integral_to_edge_load, integral_to_load)
            part_of_slip = slope_of_slip[record_numbers, None] * (
                integral_to_load - integral_to_edge_load
            )
            return slope[record_numbers, None] * integral_to_edge_load + part_of_slip

        loads = np.stack([records.load, records.load_after], axis=1)
        slipped = np.stack([records.slipped, records.slipped_after], axis=1)
        displacement_at_begin, displacement_at_end = displacement_at(
            np.arange(len(slope)), loads, slipped
        ).T
        force_in_slip = records.direction * (records.rise + self._friction * load_growth)
        force_change = np.where(records.direction == 0, slope * load_growth, force_in_slip)
        displacement_after = self._shift + np.cumsum(displacement_at_end - displacement_at_begin)
        mean_displacement, _ = _means(contact, records, displacement_at)
        self._total -= float(
            np.sum(force_change * (displacement_after - displacement_at_end + mean_displacement))
        )
        self._path_of_force += float(np.sum(np.abs(force_change)))
        self._shift = float(displacement_after[-1])

    @property
    def value(self) -> LoopWork:
        """The integral so far."""
        rounding = _DIGITS_OF_SHIFT * self._friction * self._size * self._path_of_force
        return LoopWork(self._unit * self._total, self._unit * rounding)


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
    allowed_error: ArrayLike,
    marks: ArrayLike = (),
    first_estimate: Array | None = None,
) -> Converged:
    """Integrals of m integrands, number k from begin[k] to end[k], by halving their ranges until
    the sum no longer changes.

    Parameters
    ----------
    work
        work(which (n,), low (n,), high (n,)) gives the integral of integrand which[k] from low[k]
        to high[k], (n,), by one rule
    begin, end
        (m,)
    allowed_error
        (m,) or one: the change at which a part has converged, `CONVERGED` of their size where
        round-off leaves as much. A part of 2^-17 of its range, or one that is not finite, is left
        as it is, and so are too many at once; the error shows that.
    marks
        (j,) ascending, where a part is cut rather than in its middle: the integrands are not smooth
        there
    first_estimate
        (m,) the integrals from `begin` to `end` by the rule of `work`, where they are known

    Examples
    --------
    >>> def midpoint(which, low, high):
    ...     return (high - low) * (low + high) / 2
    >>> by_halving(midpoint, [0.0, 1.0], [2.0, 3.0], CONVERGED).value.tolist()
    [2.0, 4.0]
    """
    begins = np.array(begin, dtype=float)
    ends = np.array(end, dtype=float)
    all_marks = np.append(marks, np.inf)
    numbers = np.arange(len(begins))
    n_halvings = np.zeros(len(begins), dtype=int)
    integrals = np.zeros(len(begins))
    errors = np.zeros(len(begins))
    allowed_errors = np.broadcast_to(allowed_error, begins.shape)
    integrals_before = first_estimate
    if integrals_before is None:
        integrals_before = work(numbers, begins, ends)
    while len(numbers):
        place_of_cut = (begins + ends) / 2
        # The mark next above the middle, else the one below it, else the middle itself: parts next
        # to nothing would change nothing.
        number_of_cut = np.searchsorted(all_marks, place_of_cut)
        margin = (ends - begins) / 16
        for nearest_mark in (all_marks[number_of_cut - 1], all_marks[number_of_cut]):
            is_inside = (nearest_mark > begins + margin) & (nearest_mark < ends - margin)
            place_of_cut = np.where(is_inside, nearest_mark, place_of_cut)
            n_halvings = np.where(is_inside, -1, n_halvings)
        halves = work(np.tile(numbers, 2), np.r_[begins, place_of_cut], np.r_[place_of_cut, ends])
        left_halves, right_halves = np.split(halves, 2)
        changes = np.abs(left_halves + right_halves - integrals_before)
        is_last = (n_halvings == _HALVINGS) | (len(numbers) > _MOST * len(integrals) + _FEW)
        is_done = (changes <= allowed_errors[numbers]) | ~np.isfinite(changes) | is_last
        np.add.at(integrals, numbers[is_done], (left_halves + right_halves)[is_done])
        np.add.at(errors, numbers[is_done], changes[is_done])
        is_halved_further = ~is_done
        new_begins = np.r_[begins[is_halved_further], place_of_cut[is_halved_further]]
        ends = np.r_[place_of_cut[is_halved_further], ends[is_halved_further]]
        begins = new_begins
        numbers = np.tile(numbers[is_halved_further], 2)
        integrals_before = np.r_[left_halves[is_halved_further], right_halves[is_halved_further]]
        n_halvings = np.tile(n_halvings[is_halved_further] + 1, 2)
    return Converged(integrals, errors)
