"""Friction work of any load history, over the whole contact and per area at points; and, as a
check of the former, the closed integral of Q dU.

# notation: A = 2/E*; w = +-Q - f P, which grows in slip; P_c load at the stick edge, c = a(P_c);
P_x load at which a = |x|

    W    = (f A/pi) int w' Lam(P, P_c) dt,                  Lam = int_{P_c}^P ln(a(eta)/c) d eta
    W(x) = (f A/pi) int p(x, P) w' arccosh(|x|/c) dt        over the times with c < |x| < a(P)
    W    = closed-int Q dU                                  over a steady cycle

A span is the time of one direction of slip. Where the whole contact slips, |Q| stays at f P: w does
not grow, and such spans add nothing. A span is integrated by one rule for singular ends: roots
at the edges of contact, the logarithm of gross sliding and P close to 0 all lie at an end of it or
beyond. Three things make an integrand rough within a span: segments of the load path without
formulas, half-widths at which P hardly grows with a, and corners of the profile. There a rule of
fewer nodes is applied to the span, to parts of it, cut at a corner or in the middle, and to parts
of these, until that changes nothing. Fine tables are cut at a few of their knots.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import NORMAL_LOAD, TANGENTIAL_LOAD, NotFoundError
from scenes.array_types import Array
from scenes.segments import LEAST_LOAD_CHANGE
from semi_analytic.fields import KernelIntegrals
from semi_analytic.history import Span, corner_times, snapshot_of
from semi_analytic.load_series import Records, StepBlock
from semi_analytic.memory import combination_change, slip_combination, slip_combination_on_piece
from semi_analytic.profiles import Contact
from semi_analytic.quadrature import GRADED_NODE_COUNT, crowded_nodes, gauss_rule, graded_nodes
from semi_analytic.tilted_profile import TiltedProfile

Indices = NDArray[np.intp]

CONVERGED_CHANGE_SHARE = 1e-12
# How often a range is halved at most: parts of 1/131,072 of it are left as they are. So are all
# parts where they are more than so many an integral and so many more: what is left to halve then is
# the last digits of loads along which next to nothing slips.
_MOST_HALVINGS = 17
_MOST_PARTS_PER_INTEGRAL = 64
_MOST_PARTS_BESIDES = 256
# Share of U, as a sum of logarithms times loads, that its last digits may be off.
_ROUNDOFF_SHARE_OF_DISPLACEMENT = 5e-16
# Nodes of Gauss' rule while P and P_c change by less than a share: 3e-13 by the distance of the
# singularity. Above, graded, which takes 193: a million rows would take ten times as long. Close
# behind a corner, 24 that crowd to both ends.
_RELATIVE_ERROR_OF_GAUSS_RULES = 3e-13
_CLOSENESS_LIMITS = (0.05, 0.3, 0.6, 0.9)
_NODE_COUNTS = (4, 6, 12, 24)
# Records of a block that are looked at for the error of W.
_SAMPLED_RECORDS = 200
# Half-widths over the largest: 7 % apart a root of dP/da at 0.73 +- 0.24 i leaves 4e-14 of W, 16 %
# apart 2e-11.
_CUT_HALF_WIDTH_RATIOS = 2.0 ** -np.arange(0.1, 5.0, 0.1)
# Quadrature nodes that are held at a time.
_NODES_AT_ONCE = 200_000
_SMALLEST_FLOAT = float(np.finfo(float).tiny)


class WorkByDirection(NamedTuple):
    """Friction work while the upper face slips forward, and in reverse, and an estimate of the
    error of their sum; one number or (k,) at points.
    """

    forward: Array
    reverse: Array
    error: Array

    @property
    def total(self) -> Array:
        """Both together."""
        return self.forward + self.reverse


def global_dissipation(contact: Contact, modulus: float, spans: Sequence[Span]) -> WorkByDirection:
    """Friction work W of a load path over the whole contact, by the direction of slip, and its
    error [energy per unit thickness].

    W is f A/pi times the integral of w' Lam over the time of slip, A = 2/E*, w = +-Q - f P. Lam is
    the integral of ln(a/c) over the loads from P_c to P. P_c is the load at the stick edge, c =
    a(P_c), a the contact half-width. At |Q| = f P itself, where nothing sticks, nothing is added.

    From Q = 0 to k f P at constant P, W is (A f^2 P^2/(2 pi)) [(1 - k) ln(1 - k) + k - k^2/2]. f is
    the friction.

    Parameters
    ----------
    contact
        normal contact of the profile
    modulus
        E* [stress]
    spans
        times of one direction of slip, or of full stick, on one load segment each. The
        `sticking_piece` is the piece of the memory curve (tangential force up to each load) that
        holds the stick edge, None where nothing sticks

    Examples
    --------
    >>> from scenes.segments import straight_segments
    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.history import spans_along
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> spans, _ = spans_along(
    ...     None, straight_segments([(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 1.0, 0.3)]), 0.5, 0.0
    ... )  # k = 0.6
    >>> formula = 0.5**2 / math.pi * (0.4 * math.log(0.4) + 0.6 - 0.18)
    >>> round(float(global_dissipation(contact, 1.0, spans).total), 12), round(formula, 12)
    (0.004256098192, 0.004256098192)
    """
    spans_with_ranges = [
        _range_of_span(span) for span in spans if span.direction and span.sticking_piece is not None
    ]
    work_by_direction = _work_over_spans(
        contact, modulus, spans_with_ranges, 1, _span_by_span(partial(_work_in_range, contact))
    )
    return WorkByDirection(
        work_by_direction.forward[0], work_by_direction.reverse[0], work_by_direction.error[0]
    )


QuadratureRule = Callable[[ArrayLike, ArrayLike], tuple[Array, Array]]
"""Nodes and weights between ends (n,): (n, nodes) each."""


class SpanRanges(NamedTuple):
    """A span of slip, and ranges of time within it, (n,) each: the number of the integral (of the
    point) that a range belongs to, and the times at its ends.
    """

    span: Span
    integral_number: Indices
    begin_times: Array
    end_times: Array


def _work_in_range(contact: Contact, span_with_ranges: SpanRanges, rule: QuadratureRule) -> Array:
    """Friction work W pi/A of a range of time within a span of slip, by a quadrature `rule`, (1,):
    the integral of f w' Lam. w = +-Q - f P grows in slip; Lam is the integral of ln(a/c) over the
    loads from P_c, that at the stick edge, to P; a and c are the half-widths of contact and of
    stick, A = 2/E*, E* the composite modulus, f the friction.
    """
    span = span_with_ranges.span
    times, weights = rule(span_with_ranges.begin_times, span_with_ranges.end_times)
    load, _ = span.segment.loads(times)
    slip_zone_load = span.slip_zone_load_at(times, load)  # P - P_c
    kernel = contact.dissipation_kernel(load, slip_zone_load)  # Lam
    # `_scaled_excess_rate`: f w'
    return np.asarray(np.sum(weights * _scaled_excess_rate(span, times) * kernel, axis=-1))


def _range_of_span(span: Span) -> SpanRanges:
    """One range, from begin to end of the span, for integral number 0."""
    begin_times = np.array([span.begin.time])
    return SpanRanges(span, np.zeros(1, dtype=int), begin_times, np.array([span.end.time]))


RangeIntegrator = Callable[[Sequence[SpanRanges], QuadratureRule], Sequence[Array]]
"""Gives the integrals along the ranges of each of some spans, by one rule: (n,) for each span."""


def _span_by_span(integrate_span: Callable[[SpanRanges, QuadratureRule], Array]) -> RangeIntegrator:
    """A function that integrates along several spans of slip, one after the other, by one
    quadrature rule. It is made from `integrate_span`, which integrates along a single span.
    """

    def integrate_ranges(
        spans_with_ranges: Sequence[SpanRanges], rule: QuadratureRule
    ) -> list[Array]:
        return [integrate_span(span_with_ranges, rule) for span_with_ranges in spans_with_ranges]

    return integrate_ranges


def _work_over_spans(
    contact: Contact,
    modulus: float,
    spans_with_ranges: Sequence[SpanRanges],
    n_integrals: int,
    integrate_ranges: RangeIntegrator,
) -> WorkByDirection:
    """Friction work: A/pi times integrals over the time of slip, summed by the direction of slip,
    and the errors of the sums; A = 2/E*.

    There is one integral, for the work W, or one for each point x, for the work per area W(x). A
    span is the time of one direction of slip. Each is integrated by one quadrature rule. Where the
    edges of contact or stick move unevenly, or pass corners of the profile, its ranges are halved.
    Halving ends where it changes the integral by less than 1e-12 of the largest integral, across
    corners by even less.

    Parameters
    ----------
    contact
        normal contact of the profile
    modulus
        E* [stress]
    spans_with_ranges
        one object for each span: the ranges of time in it over which to integrate, and the integral
        to which each range belongs
    n_integrals
        number of integrals: one, or one for each point
    integrate_ranges
        function: integrates f w' Lam (of W) or f w' p arccosh(|x|/c) (of W(x)) over the ranges of
        given spans by a given quadrature rule. w = +-Q - f P grows in slip, p is the pressure, c
        the stick half-width. Lam is the integral of ln(a/c) over the loads from the stick edge to
        P, a the contact half-width

    Returns
    -------
    WorkByDirection
        forward, reverse and the error of both, (n_integrals,) each
    """
    halving = _Halving.of_spans(contact, spans_with_ranges)
    integrals = _first_estimates(
        spans_with_ranges, n_integrals, integrate_ranges, halving.needs_halving
    )
    errors = np.zeros(integrals.shape)
    if np.any(halving.needs_halving):
        _halve_ranges(spans_with_ranges, integrate_ranges, halving, integrals, errors)

    # sum by the direction of slip
    is_forward = np.array(
        [span_with_ranges.span.direction > 0 for span_with_ranges in spans_with_ranges], dtype=bool
    )
    compliance_over_pi = 2 / (math.pi * modulus)  # A/pi
    return WorkByDirection(
        forward=compliance_over_pi * np.sum(integrals[is_forward], axis=0),
        reverse=compliance_over_pi * np.sum(integrals[~is_forward], axis=0),
        error=compliance_over_pi * np.sum(errors, axis=0),
    )


class _Halving(NamedTuple):
    """Which spans of slip are integrated by halving of their ranges of time, and how finely.

    Attributes
    ----------
    corner_times
        times at which an edge of contact or of stick passes a corner of the profile, for each span
    needs_halving
        (n,) whether a span has ranges of time and its edges pass a corner or move unevenly
    converged_change_share
        (n,) change by halving at which a part has converged, divided by the size of the integrals:
        1e-12 (CONVERGED_CHANGE_SHARE), less across corners
    """

    corner_times: Sequence[Array]
    needs_halving: NDArray[np.bool_]
    converged_change_share: Array

    @classmethod
    def of_spans(cls, contact: Contact, spans_with_ranges: Sequence[SpanRanges]) -> _Halving:
        """Which of n spans of slip are integrated by halving, and how finely: those in which the
        edges of contact or stick pass a corner of the profile, or may run unevenly.

        `contact` is the normal contact P(a), with the relative round-off of its P and dP/da.
        `spans_with_ranges` are the spans, each with its ranges of time; without a range there is
        nothing to halve.
        """
        corner_times_of_spans = [
            corner_times(contact, span_with_ranges.span) for span_with_ranges in spans_with_ranges
        ]
        passes_corner = np.array(
            [len(times_at_corners) > 0 for times_at_corners in corner_times_of_spans], dtype=bool
        )
        needs_halving = np.array(
            [
                len(span_with_ranges.integral_number) > 0
                and (span_passes_corner or has_uneven_edges(contact, span_with_ranges.span))
                for span_passes_corner, span_with_ranges in zip(
                    passes_corner, spans_with_ranges, strict=True
                )
            ],
            dtype=bool,
        )
        # Across corners 25 times the relative round-off of the contact's P and dP/da, about 1e-14:
        # many small kinks may hide from one halving.
        converged_change_share = np.where(
            passes_corner,
            min(CONVERGED_CHANGE_SHARE, 25 * contact.relative_roundoff),
            CONVERGED_CHANGE_SHARE,
        )
        return cls(corner_times_of_spans, needs_halving, converged_change_share)


def _first_estimates(
    spans_with_ranges: Sequence[SpanRanges],
    n_integrals: int,
    integrate_ranges: RangeIntegrator,
    needs_halving: NDArray[np.bool_],
) -> Array:
    """Integrals over the ranges of time of each of n spans of slip, by one quadrature rule each,
    (n, n_integrals); 0 where a span has no range for an integral.

    A span that `needs_halving` (n,) later takes a rule of 24 nodes, another one the rule of 193
    nodes for any singular ends. `integrate_ranges` integrates over the ranges of given spans by a
    given rule.
    """
    has_ranges = np.array(
        [len(span_with_ranges.integral_number) > 0 for span_with_ranges in spans_with_ranges],
        dtype=bool,
    )
    integrals = np.zeros((len(spans_with_ranges), n_integrals))
    for rule, takes_rule in ((graded_nodes, ~needs_halving), (crowded_nodes, needs_halving)):
        span_numbers = np.flatnonzero(has_ranges & takes_rule).tolist()
        if not span_numbers:
            continue
        spans_of_rule = [spans_with_ranges[span_number] for span_number in span_numbers]
        integrals_of_spans = integrate_ranges(spans_of_rule, rule)
        for span_number, span_with_ranges, integrals_of_span in zip(
            span_numbers, spans_of_rule, integrals_of_spans, strict=True
        ):
            integrals[span_number, span_with_ranges.integral_number] = integrals_of_span
    return integrals


def _halve_ranges(
    spans_with_ranges: Sequence[SpanRanges],
    integrate_ranges: RangeIntegrator,
    halving: _Halving,
    integrals: Array,
    errors: Array,
) -> None:
    """Halve the ranges of time of the spans that need it until their integrals no longer change;
    set the integrals of these spans, and as errors what the last halving changed.

    Parameters
    ----------
    spans_with_ranges
        n spans of slip, with the ranges of time in each, and the number of the integral that each
        range belongs to
    integrate_ranges
        function: integrates over the ranges of given spans by a given rule
    halving
        which spans are halved, how finely, and the times at which their ranges are cut first
    integrals
        (n, k) first estimates for each span and integral; those of the halved spans are replaced
    errors
        (n, k) filled for the halved spans
    """
    # One size for all: a short span by itself may be all round-off, and would never converge to its
    # own.
    largest_total_integral = float(np.max(np.abs(np.sum(integrals, axis=0))))
    size_of_integrals = np.maximum(largest_total_integral, np.max(np.abs(integrals), axis=1))
    allowed_error_of_span = halving.converged_change_share * size_of_integrals

    # one row for each range of a span to halve: the numbers of its span and of its integral
    halved_span_numbers = np.flatnonzero(halving.needs_halving).tolist()
    ranges_of_halved_spans = [
        spans_with_ranges[halved_span_number] for halved_span_number in halved_span_numbers
    ]
    n_ranges_of_spans = [
        len(ranges_of_span.integral_number) for ranges_of_span in ranges_of_halved_spans
    ]
    span_number = np.repeat(halved_span_numbers, n_ranges_of_spans)
    integral_number = np.concatenate(
        [ranges_of_span.integral_number for ranges_of_span in ranges_of_halved_spans]
    )
    integrate_parts = partial(
        _integrals_of_parts, spans_with_ranges, integrate_ranges, span_number, integral_number
    )
    corner_times_of_spans = [
        halving.corner_times[halved_span_number] for halved_span_number in halved_span_numbers
    ]
    integrals_and_errors = integrals_by_halving(
        integrate_parts,
        np.concatenate([ranges_of_span.begin_times for ranges_of_span in ranges_of_halved_spans]),
        np.concatenate([ranges_of_span.end_times for ranges_of_span in ranges_of_halved_spans]),
        allowed_error_of_span[span_number],
        np.unique(np.concatenate(corner_times_of_spans)),
        first_estimate=integrals[span_number, integral_number],
    )
    integrals[span_number, integral_number] = integrals_and_errors.value
    errors[span_number, integral_number] = integrals_and_errors.error


def _integrals_of_parts(
    spans_with_ranges: Sequence[SpanRanges],
    integrate_ranges: RangeIntegrator,
    span_number: Indices,
    integral_number: Indices,
    range_number: Indices,
    begin_times: Array,
    end_times: Array,
) -> Array:
    """Integrals over n parts of the ranges of time that are being halved, (n,), by the rule of 24
    nodes: those of the friction work, or of the work per area at points.

    Parameters
    ----------
    spans_with_ranges
        the spans of slip in one direction, with their ranges of time
    integrate_ranges
        function: integrates over given ranges by a given rule
    span_number, integral_number
        (m,) number of the span, and of the integral (of the point), of each range that is halved
    range_number
        (n,) which of these m ranges each part belongs to
    begin_times, end_times
        (n,) times at which the parts begin and end
    """
    span_number_of_part = span_number[range_number]
    halved_span_numbers = np.unique(span_number_of_part).tolist()
    part_numbers_of_spans = [
        np.flatnonzero(span_number_of_part == halved_span_number)
        for halved_span_number in halved_span_numbers
    ]
    # each part as a range of time in its span
    spans_with_parts = [
        SpanRanges(
            spans_with_ranges[halved_span_number].span,
            integral_number[range_number[part_numbers]],
            begin_times[part_numbers],
            end_times[part_numbers],
        )
        for halved_span_number, part_numbers in zip(
            halved_span_numbers, part_numbers_of_spans, strict=True
        )
    ]
    integrals = np.zeros(len(range_number))
    for part_numbers, integrals_in_span in zip(
        part_numbers_of_spans, integrate_ranges(spans_with_parts, crowded_nodes), strict=True
    ):
        integrals[part_numbers] = integrals_in_span
    return integrals


def _scaled_excess_rate(span: Span, times: Array) -> Array:
    """f dw/dt >= 0 at times of a span of slip [force per thickness per time], w = +-Q - f P the
    excess of the tangential force over the friction limit.
    """
    return span.friction * np.maximum(
        span.segment.rate_of(slip_combination(span.direction, span.friction), times), 0.0
    )


def has_uneven_edges(contact: Contact, span: Span) -> bool:
    """Whether the edges of contact or stick may run unevenly within a span of slip in one
    direction: the load, or the edge of stick along an arc, has no formula in time, or P may hardly
    grow with a.

    An arc is a curved piece of the memory curve, tangential force of the flat punches up to each
    load. `half_width_may_be_steep` states that P may hardly grow with a, the contact half-width. An
    ellipse of P and Q has formulas.
    """
    if contact.half_width_may_be_steep:
        return True
    if span.segment.ellipse is not None:
        return False
    if span.sticking_piece is not None and span.sticking_piece.arc_times is not None:
        return True
    # no formula: neither straight nor with P linear in time and Q(P) a parabola
    return not (span.segment.is_straight or span.segment.slope_and_bend(span.segment.end))


def pointwise_dissipation(
    contact: Contact, modulus: float, spans: Sequence[Span], x: Array
) -> WorkByDirection:
    """Friction work per area W(x) of a load path at |x| = `x` (k,), by the direction of slip, and
    its error, (k,) each [energy per area].

    A span is the time of one direction of slip, or of full stick. A point that always sticks, or is
    never in contact, has W(x) = 0. While Q grows at constant P, W(x) is f p(x) s(x) with the slip s
    = (f A/pi) [S(x, P) - S(x, P_c)]. S(x, P) is the integral of arccosh(|x|/a) over the loads up to
    P, a the contact half-width. P_c is the load at the stick edge, A = 2/E*, E* = `modulus`. In
    general W(x) is f A/pi times the integral of p w' arccosh(|x|/c) over the time of slip, w = +-Q
    - f P, c = a(P_c). f is the friction.

    >>> from scenes.segments import straight_segments
    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.history import spans_along
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> spans, _ = spans_along(
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
    contact_edge_loads = contact.load(x)  # P_x, at which the edge of contact is at the point
    spans_with_ranges = [
        _ranges_with_slip(span, contact_edge_loads)
        for span in spans
        if span.direction and span.sticking_piece is not None
    ]
    work_per_area_in_ranges = partial(_work_per_area_in_ranges, contact, x, contact_edge_loads)
    # A/pi times the integrals, summed by direction of slip; `_span_by_span` takes one span after
    # the other
    return _work_over_spans(
        contact, modulus, spans_with_ranges, len(x), _span_by_span(work_per_area_in_ranges)
    )


def _ranges_with_slip(span: Span, contact_edge_loads: Array) -> SpanRanges:
    """The ranges of time within a span of slip in which points slip, one for each point that does;
    the number of the integral is that of the point. `contact_edge_loads` (k,) are the loads P_x at
    which the edge of contact is at each point.
    """
    # (k,) each; the end is not after the start where a point never slips
    begin_time, end_time = slip_times(span, contact_edge_loads)
    points_with_slip = np.flatnonzero(end_time > begin_time)
    return SpanRanges(
        span, points_with_slip, begin_time[points_with_slip], end_time[points_with_slip]
    )


def _work_per_area_in_ranges(
    contact: Contact,
    x: Array,
    contact_edge_loads: Array,
    span_with_ranges: SpanRanges,
    rule: QuadratureRule,
) -> Array:
    """Friction work per area W(x) pi/A in the ranges of time in which n points slip, (n,): the
    integral of f w' p arccosh(|x|/c) over each range.

    w = +-Q - f P grows in slip, c is the half-width of stick, p the pressure, A = 2/E*, E* the
    composite modulus, f the friction.

    Parameters
    ----------
    contact
        normal contact of the profile
    x, contact_edge_loads
        (k,) |x| of all points, and the loads P_x at which the edge of contact is at each
    span_with_ranges
        a span of slip, and n ranges of time within it; `integral_number` is that of the point
    rule
        quadrature rule: nodes and weights between begin and end of the ranges
    """
    span = span_with_ranges.span
    times, weights = rule(span_with_ranges.begin_times, span_with_ranges.end_times)
    x_of_points = x[span_with_ranges.integral_number, None]
    # P and P_c, the load at the stick edge, at the nodes, (n, nodes); P_x - P_c
    load, _ = span.segment.loads(times)
    stick_edge_load = load - span.slip_zone_load_at(times, load)
    contact_edge_load_of_points = contact_edge_loads[span_with_ranges.integral_number, None]
    load_outside_stick = np.maximum(contact_edge_load_of_points - stick_edge_load, 0.0)
    arccosh_ratio = contact.arccosh_ratio(
        x_of_points, load_outside_stick, contact.edge_advance(stick_edge_load)
    )
    pressure = contact.pressure(x_of_points, load)
    # `_scaled_excess_rate`: f w'
    work_at_nodes = weights * _scaled_excess_rate(span, times) * pressure * arccosh_ratio
    return np.asarray(np.sum(work_at_nodes, axis=-1))


def slip_times(span: Span, contact_edge_load: Array) -> tuple[Array, Array]:
    """Times at which points begin and end to slip within a span of slip in one direction, (k,)
    each; the end is not after the start where a point never slips.

    A point slips while it is in contact and outside the stick zone. It begins when the stick edge,
    or the edge of contact, reaches it.

    Parameters
    ----------
    span
        the span: its load segment, and the instants at its ends, each with its time and P
    contact_edge_load
        (k,) P_x, the load at which the edge of contact is at the point
    """
    segment = span.segment
    begin_instant = span.begin
    end_instant = span.end
    time_of_stick_edge = _times_of_stick_edge(span, contact_edge_load)
    time_of_contact_edge = segment.time_of(
        NORMAL_LOAD,
        contact_edge_load - begin_instant.normal_load,
        begin_instant.time,
        end_instant.time,
    )
    end_of_span = np.full(time_of_stick_edge.shape, end_instant.time)
    # From the change itself: where P hardly moves, the difference of the loads at both ends may
    # have the wrong sign by round-off.
    load_change = float(segment.change_of(NORMAL_LOAD, end_instant.time, begin_instant.time))
    # P grows, by LEAST_LOAD_CHANGE = 1e-290 or more: the edge of contact may reach the point from
    # within.
    if load_change >= LEAST_LOAD_CHANGE:
        time_of_first_contact = np.where(
            contact_edge_load >= end_instant.normal_load, end_instant.time, time_of_contact_edge
        )
        return np.maximum(time_of_stick_edge, time_of_first_contact), end_of_span

    # P falls or stays the same: the edge of contact leaves the point, or stays.
    contact_reaches_point = contact_edge_load < max(
        begin_instant.normal_load, end_instant.normal_load
    )
    end_time = time_of_contact_edge if load_change <= -LEAST_LOAD_CHANGE else end_of_span
    return time_of_stick_edge, np.where(contact_reaches_point, end_time, time_of_stick_edge)


def _times_of_stick_edge(span: Span, contact_edge_load: Array) -> Array:
    """Times at which the stick edge reaches points within a span of slip, (k,): the start of the
    span where it has passed a point before, the end where it does not reach it.

    The stick edge is at P_x when the path's excess, +-Q - f P, equals that of the memory curve
    there, +-M(P_x) - f P_x. M(eta) is the tangential force of the flat punches up to the load eta.
    f is the friction.

    Parameters
    ----------
    span
        span of slip; its `sticking_piece` is the piece of the memory curve that holds the stick
        edge, from `bottom_load` to `top_load`
    contact_edge_load
        (k,) P_x, the load at which the edge of contact is at the point
    """
    sticking_piece = span.sticking_piece
    assert sticking_piece is not None  # for the type checker: the span has a stick zone
    # the combination +-Q - f P of the loads
    excess_combination = slip_combination(span.direction, span.friction)
    # P_x, or the nearer end of the piece
    load_on_piece = np.clip(contact_edge_load, sticking_piece.bottom_load, sticking_piece.top_load)
    excess_on_curve = slip_combination_on_piece(
        sticking_piece, span.direction, span.friction, load_on_piece
    )
    # From the path's excess at the start of the span: both count from the instant of the anchor.
    excess_at_begin = float(
        combination_change(sticking_piece.anchor, span.segment, excess_combination, span.begin.time)
    )
    excess_rise = excess_on_curve - excess_at_begin
    # when the path's excess has risen by so much
    time_of_stick_edge = span.segment.time_of(
        excess_combination, excess_rise, span.begin.time, span.end.time
    )
    time_of_stick_edge = np.where(
        contact_edge_load <= sticking_piece.bottom_load, span.end.time, time_of_stick_edge
    )
    return np.where(
        contact_edge_load >= sticking_piece.top_load, span.begin.time, time_of_stick_edge
    )


def closed_integral(contact: Contact, modulus: float, spans: Sequence[Span]) -> LoopWork:
    """The closed integral of Q dU over a steady cycle, the work of the tangential force [energy per
    unit thickness], and the round-off error that U may leave in it.

    It is the area of the hysteresis loop, and equals the friction work. It is taken as -int U dQ,
    where a constant added to U, the relative tangential displacement, changes nothing; nor does any
    multiple of Q. A span is the time of one direction of slip, or of full stick. `contact` is the
    normal contact P(a), `modulus` E*.

    Of Q between -k f P and k f P at constant P: (2 A f^2 P^2/pi) [(1 - k) ln(1 - k) + k - k^2/2],
    A = 2/E*.

    >>> from scenes.segments import straight_segments
    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.history import spans_along
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> rows = [
    ...     (0.0, 0.0, 0.0),
    ...     (1.0, 1.0, 0.0),
    ...     (2.0, 1.0, 0.3),
    ...     (3.0, 1.0, -0.3),
    ...     (4.0, 1.0, 0.3),
    ... ]  # k = 0.6
    >>> spans, _ = spans_along(None, straight_segments(rows), 0.5, 0.0)
    >>> formula = 4 * 0.5**2 / math.pi * (0.4 * math.log(0.4) + 0.6 - 0.18)
    >>> spans_of_cycle = [span for span in spans if span.begin.time >= 2.0]
    >>> round(closed_integral(contact, 1.0, spans_of_cycle).value, 12), round(formula, 12)
    (0.017024392768, 0.017024392768)
    """
    largest_load = max(max(span.begin.normal_load, span.end.normal_load) for span in spans)
    # U is counted from a datum at half the largest half-width
    contact_with_datum = _with_moved_datum(contact, largest_load)
    # integrals of ln(2 L/a) over memory curves, U pi/A, L the length of the datum; x plays no part
    displacement_integrals = KernelIntegrals(contact_with_datum, np.zeros(1), "shift")
    # pi/A times the round-off error
    scaled_roundoff = _roundoff_of_loop(contact_with_datum, spans, largest_load)
    # one range of time for each span
    spans_with_ranges = [_range_of_span(span) for span in spans]
    # -int U dQ over ranges of time, times pi/A
    integrate_ranges = partial(_works_of_ranges, displacement_integrals)
    # A/pi times the sum over all spans
    integral_of_loop = _work_over_spans(
        contact_with_datum, modulus, spans_with_ranges, 1, integrate_ranges
    ).total[0]
    return LoopWork(float(integral_of_loop), 2 / (math.pi * modulus) * scaled_roundoff)


def _roundoff_of_loop(contact: Contact, spans: Sequence[Span], largest_load: float) -> float:
    """Round-off error of pi/A times the closed integral of Q dU over the spans of a cycle, A = 2/E*
    [force^2 per thickness^2].

    The relative tangential displacement U is a sum of logarithms times loads up to f P, however
    little of it changes. Its round-off error counts along the whole way that Q goes. `contact` has
    the datum of U, `largest_load` is the largest P. A span is the time of one direction of slip, or
    of full stick. E* is the composite modulus, f the friction.
    """
    # `approach_integral`: the integral of ln(2 L/a) over the loads up to P. L is the datum
    # length, a(P) the contact half-width.
    displacement_size = 2 * abs(float(contact.approach_integral(largest_load)))
    total_change_of_force = 0.0
    for span in spans:
        _, force = span.segment.loads(np.linspace(span.begin.time, span.end.time, 5))
        total_change_of_force += float(np.sum(np.abs(np.diff(force))))
    # _ROUNDOFF_SHARE_OF_DISPLACEMENT: 5e-16
    roundoff_of_displacement = (
        _ROUNDOFF_SHARE_OF_DISPLACEMENT * spans[0].friction * displacement_size
    )
    return roundoff_of_displacement * total_change_of_force


def _works_of_ranges(
    displacement_integrals: KernelIntegrals,
    spans_with_ranges: Sequence[SpanRanges],
    rule: QuadratureRule,
) -> list[Array]:
    """pi/A times -int U dQ over the ranges of time of each span, (n,) for a span of n ranges, by a
    quadrature rule in time.

    U is the relative tangential displacement, A = 2/E*. U pi/A is an integral over the memory curve
    (tangential force up to each load) at each time. It is evaluated at the nodes of all spans in
    one call. E* is the composite modulus.

    Parameters
    ----------
    displacement_integrals
        integrals over memory curves that are U pi/A
    spans_with_ranges
        spans of one direction of slip, or of full stick, and ranges of time in each
    rule
        nodes and weights between begin and end of n ranges, (n, nodes) each
    """
    nodes_and_weights_of_spans = [
        rule(span_with_ranges.begin_times, span_with_ranges.end_times)
        for span_with_ranges in spans_with_ranges
    ]
    spans_and_times = [
        (span_with_ranges.span, times.ravel())
        for span_with_ranges, (times, _) in zip(
            spans_with_ranges, nodes_and_weights_of_spans, strict=True
        )
    ]
    displacement_at_all_times = displacement_integrals.over_memory_curves(
        snapshot_of(spans_and_times)
    )[:, 0]
    split_positions = np.cumsum([len(times) for _, times in spans_and_times])[:-1]
    displacements_of_spans = np.split(displacement_at_all_times, split_positions)
    works_of_spans = []
    for span_with_ranges, (times, weights), displacement_of_span in zip(
        spans_with_ranges, nodes_and_weights_of_spans, displacements_of_spans, strict=True
    ):
        displacement = displacement_of_span.reshape(times.shape)
        force_rate = span_with_ranges.span.segment.rate_of(TANGENTIAL_LOAD, times)
        works_of_spans.append(-np.sum(displacement * force_rate * weights, axis=1))
    return works_of_spans


def _with_moved_datum(contact: Contact, largest_load: float) -> Contact:
    """A contact whose displacement U counts from a moved datum: the datum length L becomes half the
    largest half-width, so that ln(2 L/a) is 0 where the contact is largest.

    A moved datum adds a multiple of Q to U, which does not change the closed integral of U dQ. It
    keeps digits where the logarithm hardly varies, as for a face that is nearly all flat.
    `largest_load` is the largest P.
    """
    contact_with_datum = replace(contact, datum_length=float(contact.half_width(largest_load)) / 2)
    if isinstance(contact_with_datum, TiltedProfile):
        # The kernel becomes that of U + kappa m_q in place of U, m_q the moment of the shear: bulk
        # strain does work too, so that W is minus the closed integral of (U + kappa m_q) dQ. kappa
        # is the bulk strain per Q, and the tilt per P.
        return replace(contact_with_datum, kernel_quantity="conjugate_displacement")
    return contact_with_datum


FunctionOfLoads = Callable[[Indices, Array, Array], Array]
"""A function of the loads: of record numbers (n,), P and P - P_c (n, k), with values (n, k)."""


def _means_along_records(
    contact: Contact, records: Records, function_of_loads: FunctionOfLoads
) -> tuple[Array, int]:
    """Mean of a function of P and P - P_c along each record of slip, (m,), and the number of
    quadrature nodes that it took.

    A record is a portion of a load step in which P and P_c, the load at the stick edge, change
    linearly. It is first cut into parts along which the half-width a(P) is smooth. The function is
    singular at P = 0 and P_c = 0. At a load d above that of a corner of the profile it goes as
    d^(3/2), which nodes that crowd to both ends resolve.

    Parameters
    ----------
    contact
        normal contact P(a), and the loads at which its edge is at a corner of the profile
    records
        the records, with P and P - P_c at begin and end
    function_of_loads
        the function of (record numbers (n,), P, P - P_c (n, nodes)): (n, nodes)
    """
    smooth_parts = _cut_where_unsmooth(contact, records)
    # the nearer a singularity, or a corner below, the more nodes
    rule_number_of_part = _rule_numbers(
        _closeness_of_loads(smooth_parts, np.empty(0)),
        _closeness_of_loads(smooth_parts, contact.corner_loads),
    )
    mean_of_records = np.zeros(len(records.step_number))
    n_nodes = 0
    # six rules: Gauss' of 4, 6, 12 and 24 nodes, graded, and crowded to both ends
    for rule_number, (rule, _) in enumerate(_RULES_AND_NODE_COUNTS):
        place_in_part, weights = rule(0.0, 1.0)
        parts_of_rule = smooth_parts.take(np.flatnonzero(rule_number_of_part == rule_number))
        load, slip_zone_load = _loads_at_places(parts_of_rule, place_in_part)
        record_number = parts_of_rule.record_number
        values_at_nodes = function_of_loads(record_number, load, np.clip(slip_zone_load, 0.0, load))
        # share of its record that each part takes, times the mean along the part
        means_of_parts = parts_of_rule.share_of_record * np.sum(weights * values_at_nodes, axis=1)
        mean_of_records += np.bincount(record_number, means_of_parts, len(mean_of_records))
        n_nodes += load.size
    return mean_of_records, n_nodes


def _loads_at_places(parts: _RecordParts, places: Array) -> tuple[Array, Array]:
    """P and P - P_c at places (k,) from 0 to 1 along parts of slip records, (m, k) each [force per
    thickness]; both change linearly, P_c is the load at the stick edge.
    """
    load_growth = parts.load_at_end - parts.load_at_begin
    slip_zone_growth = parts.slip_zone_load_at_end - parts.slip_zone_load_at_begin
    load = parts.load_at_begin[:, None] + load_growth[:, None] * places
    slip_zone_load = parts.slip_zone_load_at_begin[:, None] + slip_zone_growth[:, None] * places
    return load, slip_zone_load


def _gauss_rule(n_nodes: int) -> QuadratureRule:
    """Gauss' quadrature rule of `n_nodes` nodes, as a function of begin and end of ranges (n,) that
    returns nodes and weights (n, n_nodes) each.
    """
    unit_nodes, unit_weights = gauss_rule(n_nodes)

    def rule(begin: ArrayLike, end: ArrayLike) -> tuple[Array, Array]:
        """Nodes and weights on ranges from begin to end."""
        begin_column = np.asarray(begin, dtype=float)[..., None]
        range_length = np.asarray(end, dtype=float)[..., None] - begin_column
        return begin_column + range_length * unit_nodes, range_length * unit_weights

    return rule


_RULES_AND_NODE_COUNTS: tuple[tuple[QuadratureRule, int], ...] = (
    *((_gauss_rule(count), count) for count in _NODE_COUNTS),
    (graded_nodes, GRADED_NODE_COUNT),
    (crowded_nodes, len(crowded_nodes(0.0, 1.0)[0])),
)
"""Rules for parts of records of slip and their numbers of nodes: Gauss' of 4, 6, 12 and 24 nodes;
the rule for singular ends (graded); the one whose nodes crowd to both ends.
"""


def _rule_numbers(closeness_to_singularity: Array, closeness_to_corner: Array) -> Indices:
    """Number of the quadrature rule in `_RULES_AND_NODE_COUNTS` for each of m integrands, (m,):
    more nodes the nearer a singularity, crowded nodes next to a corner of the profile.

    Closeness is 1 - d_min/d_max with the distances d of a load from the singularity, or from the
    load of the corner below, along the range of integration: 0 far away, 1 where it is reached.
    """
    # _CLOSENESS_LIMITS: 0.05, 0.3, 0.6 and 0.9, up to which Gauss' rules of 4, 6, 12 and 24 nodes
    # serve; number 4 is the graded rule, number 5 the crowded one
    rule_number = np.searchsorted(_CLOSENESS_LIMITS, closeness_to_singularity)
    is_beside_corner = closeness_to_corner > np.maximum(
        closeness_to_singularity, _CLOSENESS_LIMITS[0]
    )
    takes_gauss_rule = rule_number < len(_CLOSENESS_LIMITS)
    rule_number[takes_gauss_rule & is_beside_corner] = len(_CLOSENESS_LIMITS) + 1
    return rule_number


def _closeness_of_loads(parts: _RecordParts, corner_loads: Array) -> Array:
    """How close P or P_c comes to 0, or to the load of the profile's corner below, along each part
    of a slip record, (m,): from 0, far, to 1, reached.

    It is 1 - d_min/d_max with the distances d along the part, the larger value of P and P_c. P_c is
    the load at the stick edge.

    Parameters
    ----------
    parts
        parts of records, which are portions of load steps, with P and P - P_c (`slip_zone_load`) at
        begin and end
    corner_loads
        (c,) ascending loads at which the contact edge is at a corner; empty for the distance from 0
    """
    largest_closeness = np.zeros(len(parts.record_number))
    stick_edge_load_at_begin = parts.load_at_begin - parts.slip_zone_load_at_begin
    stick_edge_load_at_end = parts.load_at_end - parts.slip_zone_load_at_end
    for begin_load, end_load in (
        (parts.load_at_begin, parts.load_at_end),
        (stick_edge_load_at_begin, stick_edge_load_at_end),
    ):
        least_load = np.minimum(begin_load, end_load)
        largest_load = np.maximum(begin_load, end_load)
        # 0 below the first corner
        corner_load_below = np.append(0.0, corner_loads)[
            np.searchsorted(corner_loads, (least_load + largest_load) / 2)
        ]
        closeness_of_load = _closeness(
            least_load - corner_load_below, largest_load - corner_load_below
        )
        largest_closeness = np.maximum(largest_closeness, closeness_of_load)
    return largest_closeness


def _closeness(distance_at_begin: Array, distance_at_end: Array) -> Array:
    """1 - d_min/d_max of a distance d >= 0 that changes linearly between the ends of a range: 0
    where it does not change, 1 where it is 0 at an end.
    """
    least_distance = np.maximum(np.minimum(distance_at_begin, distance_at_end), 0.0)
    largest_distance = np.maximum(np.maximum(distance_at_begin, distance_at_end), _SMALLEST_FLOAT)
    return np.asarray(1 - least_distance / largest_distance)


class _RecordParts(NamedTuple):
    """Parts of slip records, n of them, along which the contact half-width a(P) is smooth at P and
    at P_c, the load at the stick edge. A record is a portion of a load step.

    Attributes
    ----------
    record_number
        (n,) number of the record that the part belongs to
    share_of_record
        (n,) share of the record that the part takes
    load_at_begin, load_at_end
        (n,) P at both ends of the part [force per thickness]
    slip_zone_load_at_begin, slip_zone_load_at_end
        (n,) P - P_c there
    level_rise
        (n,) growth of +-Q - f P along the part
    """

    record_number: Indices
    share_of_record: Array
    load_at_begin: Array
    load_at_end: Array
    slip_zone_load_at_begin: Array
    slip_zone_load_at_end: Array
    level_rise: Array

    def take(self, numbers: Indices | slice) -> _RecordParts:
        """The parts of these numbers, or of a slice."""
        return _RecordParts._make(column[numbers] for column in self)


def _cut_where_unsmooth(contact: Contact, records: Records) -> _RecordParts:
    """Records of slip, cut so that a(P), the half-width of the contact, is smooth along each part
    at P and at P_c, the load at the stick edge.

    A record is a portion of a load step in which P and P_c change linearly; it holds P and P - P_c
    at both ends, and `level_rise`, the growth of +-Q - f P. f is the friction.
    """
    shares_at_lower_cut = _shares_at_cuts(records, _loads_of_cuts(contact, records))
    shares_at_upper_cut = np.append(
        shares_at_lower_cut[:, 1:], np.ones((len(shares_at_lower_cut), 1)), axis=1
    )
    # parts between neighbouring cuts
    record_number, cut_number = np.nonzero(shares_at_upper_cut > shares_at_lower_cut)
    lower_share = shares_at_lower_cut[record_number, cut_number]
    upper_share = shares_at_upper_cut[record_number, cut_number]

    # P and P - P_c at the ends of the parts
    load_at_record_begin = records.load_at_begin[record_number]
    load_growth = (records.load_at_end - records.load_at_begin)[record_number]
    slip_zone_load_at_record_begin = records.slip_zone_load_at_begin[record_number]
    slip_zone_growth = (records.slip_zone_load_at_end - records.slip_zone_load_at_begin)[
        record_number
    ]
    return _RecordParts(
        record_number=record_number,
        share_of_record=upper_share - lower_share,
        load_at_begin=load_at_record_begin + lower_share * load_growth,
        load_at_end=load_at_record_begin + upper_share * load_growth,
        slip_zone_load_at_begin=slip_zone_load_at_record_begin + lower_share * slip_zone_growth,
        slip_zone_load_at_end=slip_zone_load_at_record_begin + upper_share * slip_zone_growth,
        level_rise=records.level_rise[record_number] * (upper_share - lower_share),
    )


def _loads_of_cuts(contact: Contact, records: Records) -> Array:
    """Loads (c,) at which a(P), the half-width of the contact, may not be smooth: those of the
    profile's corners. Where P may hardly grow with a they are also those of half-widths 7 % apart,
    from 0.93 to 0.03 of that under the largest P of the records.
    """
    cut_loads = contact.corner_loads
    if contact.half_width_may_be_steep and len(records.step_number):
        largest_load = max(float(np.max(records.load_at_begin)), float(np.max(records.load_at_end)))
        largest_half_width = contact.half_width(largest_load)
        cut_loads = np.append(cut_loads, contact.load(largest_half_width * _CUT_HALF_WIDTH_RATIOS))
    return cut_loads


def _shares_at_cuts(records: Records, cut_loads: Array) -> Array:
    """Shares of each record of slip at which P or P_c is one of c loads, ascending after a 0, (m, 2
    c + 1).

    A share is 0 or 1 where neither comes to that load within the record. P_c is the load at the
    stick edge; both change linearly along a record.
    """
    stick_edge_load_at_begin = records.load_at_begin - records.slip_zone_load_at_begin
    stick_edge_load_at_end = records.load_at_end - records.slip_zone_load_at_end
    shares_at_cuts = [np.zeros((len(records.step_number), 1))]
    for begin_load, end_load in (
        (records.load_at_begin, records.load_at_end),
        (stick_edge_load_at_begin, stick_edge_load_at_end),
    ):
        change_of_load = np.where(end_load != begin_load, end_load - begin_load, np.inf)[:, None]
        shares_at_cuts.append(np.clip((cut_loads - begin_load[:, None]) / change_of_load, 0.0, 1.0))
    ascending_shares = np.concatenate(shares_at_cuts, axis=1)
    ascending_shares.sort(axis=1)
    return ascending_shares


def slip_work(contact: Contact, records: Records) -> tuple[Array, int]:
    """pi/(f A) times the friction work of each record of slip, int Lam dw, (m,) [force^2 per
    thickness^2], and the number of quadrature nodes that it took.

    A record is a portion of a load step with slip, w = +-Q - f P, which grows by `level_rise` along
    the record. Lam(P, P_c) is the integral of ln(a/c) over the loads from P_c to P, c = a(P_c) the
    stick half-width, A = 2/E*; the quadrature takes its mean along the record. P_c is the load at
    the stick edge. E* is the composite modulus.
    """
    mean_kernels, n_nodes = _means_along_records(
        contact,
        records,
        lambda _, load, slip_zone_load: contact.dissipation_kernel(load, slip_zone_load),
    )
    return records.level_rise * mean_kernels, n_nodes


def work_error(contact: Contact, records: Records) -> float:
    """Estimated error of pi/(f A) times the friction work of all slip records [force^2 per
    thickness^2], A = 2/E*; 0 for contacts with closed forms.

    A record is a portion of a load step; `level_rise` is the growth of +-Q - f P along it. Its work
    is that growth times the mean of the kernel int ln(a/c) d eta over the loads from P_c, that at
    the stick edge, to P. So the error is the largest error of the kernel in a sample of 200
    records, times the sum of the `level_rise` of all. a and c are the half-widths of contact and of
    stick. The error of the kernel includes 3e-13 of it for the quadrature rule. E* is the composite
    modulus.

    Raises
    ------
    NotFoundError
        Where the error of the kernel is infinite or NaN.
    """
    n_records = len(records.step_number)
    if contact.has_closed_form or not n_records:
        return 0.0
    sampled_record_numbers = np.unique(np.linspace(0, n_records - 1, _SAMPLED_RECORDS).astype(int))
    sampled_records = records.take(sampled_record_numbers)
    # P and P - P_c at both ends of the sampled records
    load = np.append(sampled_records.load_at_begin, sampled_records.load_at_end)
    slip_zone_load = np.append(
        sampled_records.slip_zone_load_at_begin, sampled_records.slip_zone_load_at_end
    )
    error_of_values = contact.quadrature_error("dissipation_kernel", load, slip_zone_load)
    error_of_rule = _RELATIVE_ERROR_OF_GAUSS_RULES * contact.dissipation_kernel(
        load, slip_zone_load
    )
    kernel_error = error_of_values + error_of_rule
    if not np.all(np.isfinite(kernel_error)):
        raise NotFoundError(
            "the error of the dissipation kernel is not a number: neither is the dissipation"
        )
    return float(np.max(kernel_error, initial=0.0) * np.sum(records.level_rise))


def density_of_records(contact: Contact, records: Records, x: Array) -> Array:
    """pi/(f A) times the friction work per area of all records of slip, at |x| = `x` (k,): the sum
    of int p arccosh(|x|/c) dw, (k,) [stress times force per thickness]; A = 2/E*.

    A record is a portion of a load step with slip. It is cut into parts along which the edges of
    contact and stick pass no corner of the profile. w = +-Q - f P grows in slip, p is the pressure
    at x and c the stick half-width. E* is the composite modulus.
    """
    scaled_work_per_area = np.zeros(len(x))
    smooth_parts = _cut_where_unsmooth(contact, records)
    # 200,000 pairs of part and point at once bound the storage
    parts_at_once = max(_NODES_AT_ONCE // len(x), 1)
    for first_part_number in range(0, len(smooth_parts.load_at_begin), parts_at_once):
        parts_of_chunk = smooth_parts.take(
            slice(first_part_number, first_part_number + parts_at_once)
        )
        scaled_work_per_area += _work_per_area_of_parts(contact, parts_of_chunk, x)
    return scaled_work_per_area


def _work_per_area_of_parts(contact: Contact, parts: _RecordParts, x: Array) -> Array:
    """pi/(f A) times the friction work per area of parts of slip records, at |x| = `x` (k,): the
    sum of int p arccosh(|x|/c) dw [stress times force per thickness]; A = 2/E*.

    w = +-Q - f P grows in slip, p is the pressure at x and c the stick half-width. p is singular
    like a square root at P = P_x, the load at which the edge of contact is at x. The arccosh is so
    at P_c = P_x, and like a logarithm at P_c = 0; P_c is the load at the stick edge. A pair of part
    and point takes as many nodes as the nearest of these needs. E* is the composite modulus.

    Parameters
    ----------
    contact
        normal contact of the profile
    parts
        parts of records, which are portions of load steps: P and P - P_c at begin and end, between
        which both change linearly and pass no corner of the profile, and the growth of w
        (`level_rise`)
    """
    pairs = _SlippingPairs.of_parts(parts, x, contact.load(x))
    closeness_to_corner = _closeness_of_loads(parts, contact.corner_loads)
    rule_number_of_pair = _rule_numbers(
        pairs.closeness_to_singularity(), closeness_to_corner[pairs.part_number]
    )
    scaled_work_per_area = np.zeros(len(x))
    # six rules, of 4 nodes and more; 200,000 nodes at once bound the storage
    for rule_number, (rule, n_nodes) in enumerate(_RULES_AND_NODE_COUNTS):
        pair_numbers_of_rule = np.flatnonzero(rule_number_of_pair == rule_number)
        pairs_at_once = _NODES_AT_ONCE // n_nodes
        for first_pair_number in range(0, len(pair_numbers_of_rule), pairs_at_once):
            pairs_of_block = pairs.take(
                pair_numbers_of_rule[first_pair_number : first_pair_number + pairs_at_once]
            )
            work_of_pairs = parts.level_rise[pairs_of_block.part_number] * _integral_over_slip(
                contact, pairs_of_block, rule
            )
            scaled_work_per_area += np.bincount(pairs_of_block.point_number, work_of_pairs, len(x))
    return scaled_work_per_area


class _LinearLoads(NamedTuple):
    """P and P_c, the load at the stick edge, along n parts of slip records in which both change
    linearly, (n, 1) each [force per thickness].

    Attributes
    ----------
    load_at_begin, load_growth
        P at the start of the part, and by how much it grows along it
    stick_edge_load_at_begin, stick_edge_drop
        P_c at the start of the part, and by how much it falls along it
    """

    load_at_begin: Array
    load_growth: Array
    stick_edge_load_at_begin: Array
    stick_edge_drop: Array

    @classmethod
    def of_parts(cls, parts: _RecordParts) -> _LinearLoads:
        """P and P_c, the load at the stick edge, as linear functions along n parts of slip records,
        from P and P - P_c at both ends of each.
        """
        load_at_begin = parts.load_at_begin[:, None]
        load_growth = (parts.load_at_end - parts.load_at_begin)[:, None]
        slip_zone_growth = parts.slip_zone_load_at_end - parts.slip_zone_load_at_begin
        return cls(
            load_at_begin=load_at_begin,
            load_growth=load_growth,
            stick_edge_load_at_begin=load_at_begin - parts.slip_zone_load_at_begin[:, None],
            stick_edge_drop=slip_zone_growth[:, None] - load_growth,
        )

    def take(self, numbers: Indices) -> _LinearLoads:
        """Those of the parts with these numbers."""
        return _LinearLoads(*(values[numbers] for values in self))

    def at(self, shares: Array) -> tuple[Array, Array]:
        """P and P_c at shares from 0 to 1 of the parts, (n, k) each; P_c is at least 0."""
        stick_edge_load = self.stick_edge_load_at_begin - self.stick_edge_drop * shares
        return self.load_at_begin + self.load_growth * shares, np.maximum(stick_edge_load, 0.0)


class _SlippingPairs(NamedTuple):
    """Pairs of a part of a slip record and a point that slips in it, n of them. A record is a
    portion of a load step.

    Attributes
    ----------
    part_number, point_number
        (n,) numbers of the part and of the point
    loads
        P and P_c, the load at the stick edge, along the part
    begin_share, end_share
        (n,) shares of the part, from 0 to 1, between which the point slips
    x, contact_edge_load
        (n, 1) |x| of the point [length], and P_x, the load at which the edge of contact is there
    """

    part_number: Indices
    point_number: Indices
    loads: _LinearLoads
    begin_share: Array
    end_share: Array
    x: Array
    contact_edge_load: Array

    @classmethod
    def of_parts(cls, parts: _RecordParts, x: Array, contact_edge_loads: Array) -> _SlippingPairs:
        """All pairs of some parts of slip records and points |x| = `x` (k,) that slip in them;
        `contact_edge_loads` (k,) is P_x, the load at which the edge of contact is at each point.
        """
        loads = _LinearLoads.of_parts(parts)
        # of the part, between which each point slips, (parts, k) each
        begin_shares, end_shares = _shares_in_slip(loads, contact_edge_loads)
        part_number, point_number = np.nonzero(end_shares > begin_shares)
        return cls(
            part_number=part_number,
            point_number=point_number,
            loads=loads.take(part_number),
            begin_share=begin_shares[part_number, point_number],
            end_share=end_shares[part_number, point_number],
            x=x[point_number, None],
            contact_edge_load=contact_edge_loads[point_number, None],
        )

    def take(self, pair_numbers: Indices) -> _SlippingPairs:
        """The pairs with these numbers."""
        return _SlippingPairs(
            part_number=self.part_number[pair_numbers],
            point_number=self.point_number[pair_numbers],
            loads=self.loads.take(pair_numbers),
            begin_share=self.begin_share[pair_numbers],
            end_share=self.end_share[pair_numbers],
            x=self.x[pair_numbers],
            contact_edge_load=self.contact_edge_load[pair_numbers],
        )

    def closeness_to_singularity(self) -> Array:
        """How close p arccosh(|x|/c) comes to its singularities while the point slips, (n,): 0 far
        away, 1 where it reaches one.

        They are at P = P_x, P_c = P_x and P_c = 0. P_x is the load at which the edge of contact is
        at the point, P_c that at the stick edge. p is the pressure at the point, c the stick
        half-width.
        """
        load_at_begin, stick_edge_load_at_begin = self.loads.at(self.begin_share[:, None])
        load_at_end, stick_edge_load_at_end = self.loads.at(self.end_share[:, None])
        contact_edge_load = self.contact_edge_load
        closeness = np.max(
            [
                _closeness(load_at_begin - contact_edge_load, load_at_end - contact_edge_load),
                _closeness(
                    contact_edge_load - stick_edge_load_at_begin,
                    contact_edge_load - stick_edge_load_at_end,
                ),
                _closeness(stick_edge_load_at_begin, stick_edge_load_at_end),
            ],
            axis=0,
        )
        return np.asarray(closeness[:, 0])


def _integral_over_slip(contact: Contact, pairs: _SlippingPairs, rule: QuadratureRule) -> Array:
    """Integral of p arccosh(|x|/c) over the shares of a part in which its point slips, for pairs of
    part and point, (n,) [stress]; p is the pressure at the point, c the stick half-width.

    A share runs from 0 to 1 along the part: times the growth of w = +-Q - f P along it this is int
    p arccosh(|x|/c) dw. `rule` gives quadrature nodes and weights between two shares. f is the
    friction.
    """
    shares_at_nodes, weights = rule(pairs.begin_share, pairs.end_share)
    load_at_nodes, stick_edge_load = pairs.loads.at(shares_at_nodes)
    load_outside_stick = np.maximum(pairs.contact_edge_load - stick_edge_load, 0.0)
    arccosh_ratio = contact.arccosh_ratio(
        pairs.x, load_outside_stick, contact.edge_advance(stick_edge_load)
    )
    integrand_at_nodes = weights * contact.pressure(pairs.x, load_at_nodes) * arccosh_ratio
    return np.asarray(np.sum(integrand_at_nodes, axis=1))


def _shares_in_slip(loads: _LinearLoads, contact_edge_load_of_points: Array) -> tuple[Array, Array]:
    """Shares from 0 to 1 of a part of a load step between which points slip, begin and end, (n, k)
    each; the end is not above the start where a point never does.

    A point slips while it is in contact and outside the stick zone: P_c < P_x < P. P_x is the load
    at which the edge of contact is at the point, P_c that at the stick edge. P and P_c change
    linearly along a part, so that each meets P_x at one share at most.

    Parameters
    ----------
    loads
        P and P_c along each of n parts, (n, 1): values at the start, growth of P, fall of P_c
    contact_edge_load_of_points
        (k,) P_x
    """
    load_at_begin, load_growth, stick_edge_load_at_begin, stick_edge_drop = loads
    share_at_stick_edge = np.clip(
        (stick_edge_load_at_begin - contact_edge_load_of_points)
        / np.where(stick_edge_drop > 0, stick_edge_drop, 1.0),
        0.0,
        1.0,
    )
    begin_share = np.where(stick_edge_drop > 0, share_at_stick_edge, 1.0)
    begin_share = np.where(
        contact_edge_load_of_points >= stick_edge_load_at_begin, 0.0, begin_share
    )
    share_at_contact_edge = np.clip(
        (contact_edge_load_of_points - load_at_begin)
        / np.where(load_growth != 0, load_growth, 1.0),
        0.0,
        1.0,
    )
    end_share = np.where(load_growth < 0, share_at_contact_edge, 1.0)
    largest_load = np.maximum(load_at_begin, load_at_begin + load_growth)
    end_share = np.where(contact_edge_load_of_points < largest_load, end_share, 0.0)
    # Where the contact grows a point slips from when the edge of contact reaches it.
    begin_share_in_growth = np.maximum(begin_share, share_at_contact_edge)
    return np.where(load_growth > 0, begin_share_in_growth, begin_share), end_share


class LoopWorkOfSeries:
    """Closed integral of Q dU over the records of a steady cycle, block by block, and its round-off
    error.

    A record is a portion of a load step in which P and P_c, the load at the stick edge, change
    linearly. With G(P) the integral of ln(2 L/a) over the loads up to P, U pi/A grows along a
    record by m times the growth of G(P_c) plus s f times that of G(P) - G(P_c). s is the direction
    of slip, m the slope of the memory curve M(eta) at the stick edge. U is the relative tangential
    displacement, A = 2/E*, a the contact half-width, L the length of the datum of U. M(eta) is the
    tangential force carried up to the load eta.
    """

    def __init__(
        self, contact: Contact, modulus: float, friction: float, largest_load: float
    ) -> None:
        """Set the closed integral of Q dU of a cycle to 0; the blocks of the cycle are added later.
        It takes the normal contact, the composite modulus E*, the friction f and the largest P.
        """
        # U counted from a datum at which ln(2 L/a) is 0 under the largest P
        self._contact = _with_moved_datum(contact, largest_load)
        self._friction = friction
        self._compliance_over_pi = 2 / (math.pi * modulus)  # A/pi, A = 2/E*
        # largest size of U pi/A over f, U the relative tangential displacement
        self._displacement_size = 2 * abs(float(self._contact.approach_integral(largest_load)))
        self._scaled_displacement = 0.0  # U pi/A at the end of the last block
        self._scaled_integral = 0.0  # -int U dQ pi/A so far
        self._total_change_of_force = 0.0  # sum of |dQ| so far

    def add_block(self, block: StepBlock) -> None:
        """Add the next block of load steps to the closed integral of Q dU of a cycle, as -int U dQ.

        U is the relative tangential displacement, A = 2/E*. U pi/A is summed record by record, a
        record being a portion of a load step with one direction of slip or none. Each takes the
        change of Q times the mean of U along it. The block holds its records, with P and P - P_c at
        both ends; P_c is the load at the stick edge. It also holds the slope of the memory curve,
        tangential force up to each load, at the stick edge of each record. E* is the composite
        modulus.
        """
        records = block.records
        # U pi/A along each record, minus a constant of the record, as a function of P and P - P_c
        displacement_minus_constant = partial(
            _displacement_minus_constant,
            self._contact,
            block.line_table.slope,
            records.direction * self._friction,
        )
        loads_at_ends = np.stack([records.load_at_begin, records.load_at_end], axis=1)
        slip_zone_loads_at_ends = np.stack(
            [records.slip_zone_load_at_begin, records.slip_zone_load_at_end], axis=1
        )
        # the function at both ends of each record, and its mean along the record
        function_at_begin, function_at_end = displacement_minus_constant(
            np.arange(len(records.direction)), loads_at_ends, slip_zone_loads_at_ends
        ).T
        function_mean, _ = _means_along_records(self._contact, records, displacement_minus_constant)

        # The mean of U along a record is U at its end plus the mean difference of U from it.
        force_change = self._force_changes(block)
        displacement_at_end = self._scaled_displacement + np.cumsum(
            function_at_end - function_at_begin
        )
        mean_displacement = displacement_at_end - function_at_end + function_mean
        self._scaled_integral -= float(np.sum(force_change * mean_displacement))
        self._total_change_of_force += float(np.sum(np.abs(force_change)))
        self._scaled_displacement = float(displacement_at_end[-1])

    def _force_changes(self, block: StepBlock) -> Array:
        """Change of Q along each record of a block, (m,) [force per thickness].

        A record is a portion of a load step. In slip Q follows from the growth `level_rise` of +-Q
        - f P. In full stick Q changes by the slope of the memory curve, the tangential force
        carried up to each load, times the change of P. f is the friction.
        """
        records = block.records
        load_growth = records.load_at_end - records.load_at_begin
        force_change_in_slip = records.direction * (
            records.level_rise + self._friction * load_growth
        )
        return np.where(
            records.direction == 0, block.line_table.slope * load_growth, force_change_in_slip
        )

    @property
    def work(self) -> LoopWork:
        """Closed integral of Q dU so far [energy per unit thickness], and its round-off error."""
        # pi/A times the error: 5e-16 of the largest U pi/A along the whole way of Q
        scaled_roundoff = (
            _ROUNDOFF_SHARE_OF_DISPLACEMENT
            * self._friction
            * self._displacement_size
            * self._total_change_of_force
        )
        return LoopWork(
            self._compliance_over_pi * self._scaled_integral,
            self._compliance_over_pi * scaled_roundoff,
        )


def _displacement_minus_constant(
    contact: Contact,
    slope_at_stick_edge: Array,
    slope_in_slip_zones: Array,
    record_numbers: Indices,
    load: Array,
    slip_zone_load: Array,
) -> Array:
    """Tangential displacement U pi/A along records, minus a constant of each record, (n, k), at P =
    `load` and P - P_c = `slip_zone_load`, (n, k) each. P_c is the load at the stick edge, A =
    2/E*.

    A record is a portion of a load step. U follows from the integral of ln(2 L/a) over the loads up
    to P, and up to P_c. L is the length of the datum of U, a the contact half-width. E* is the
    composite modulus.

    Parameters
    ----------
    contact
        normal contact P(a)
    slope_at_stick_edge, slope_in_slip_zones
        (m,) slope of the memory curve, tangential force carried up to each load, of all records: at
        the stick edge, and +-f or 0 between P_c and P
    record_numbers
        (n,) of the records
    """
    integral_to_load = contact.approach_integral(load)
    integral_to_stick_edge = contact.approach_integral(np.maximum(load - slip_zone_load, 0.0))
    integral_to_stick_edge = np.where(slip_zone_load > 0, integral_to_stick_edge, integral_to_load)
    part_of_slip_zones = slope_in_slip_zones[record_numbers, None] * (
        integral_to_load - integral_to_stick_edge
    )
    return slope_at_stick_edge[record_numbers, None] * integral_to_stick_edge + part_of_slip_zones


class LoopWork(NamedTuple):
    """Closed integral of Q dU [energy per unit thickness], and its error by rounding at most."""

    value: float
    roundoff: float


class IntegralsAndErrors(NamedTuple):
    """Integrals (m,), and an estimate of the error of each: what the last halving changed.

    The estimate does not contain what a rule leaves after any number of halvings: `graded_nodes`
    leaves 4e-12 of a part that has a pole beside its end, at whatever distance.
    """

    value: Array
    error: Array


def integrals_by_halving(
    integrate_parts: Callable[[Indices, Array, Array], Array],
    begin: ArrayLike,
    end: ArrayLike,
    allowed_error: ArrayLike,
    cut_places: ArrayLike = (),
    first_estimate: Array | None = None,
) -> IntegralsAndErrors:
    """Integrals of m integrands, number k from begin[k] to end[k], by halving their ranges until
    the sum no longer changes, and their errors (adaptive quadrature). An integral is the sum over
    its parts.

    A part that has not converged is left as it is after 17 halvings, where it is not finite, and
    where there are too many parts. Its last change by halving is in the error.

    Parameters
    ----------
    integrate_parts
        function: integrate_parts(numbers, begins, ends), (n,) each, gives the integral of integrand
        numbers[k] from begins[k] to ends[k], (n,), by one rule
    begin, end
        (m,) ends of the range of each integrand
    allowed_error
        (m,) or one: the change by halving at which a part has converged; 1e-12 of the size of the
        integrals (`CONVERGED_CHANGE_SHARE`) where round-off allows it
    cut_places
        (j,) ascending, where a part is cut rather than in its middle: the integrands are not
        smooth there
    first_estimate
        (m,) the integrals from `begin` to `end` by the rule of `integrate_parts`, where they are
        known

    Examples
    --------
    >>> def midpoint(numbers, begins, ends):
    ...     return (ends - begins) * (begins + ends) / 2
    >>> integrals_by_halving(
    ...     midpoint, [0.0, 1.0], [2.0, 3.0], CONVERGED_CHANGE_SHARE
    ... ).value.tolist()
    [2.0, 4.0]
    """
    begin_places = np.array(begin, dtype=float)
    parts = _Parts(
        integrand_number=np.arange(len(begin_places)),
        begin_place=begin_places,
        end_place=np.array(end, dtype=float),
        n_halvings=np.zeros(len(begin_places), dtype=int),
    )
    all_cut_places = np.append(cut_places, np.inf)
    integrals = np.zeros(len(begin_places))
    errors = np.zeros(len(begin_places))
    allowed_error_of_integrand = np.broadcast_to(allowed_error, begin_places.shape)
    estimates_of_parts = first_estimate
    if estimates_of_parts is None:
        estimates_of_parts = integrate_parts(
            parts.integrand_number, parts.begin_place, parts.end_place
        )

    # Each pass halves all parts that are left.
    while len(parts.integrand_number):
        cut_of_parts, is_cut_at_place = _cuts_of_parts(parts, all_cut_places)
        halves = parts.halves(cut_of_parts, is_cut_at_place)
        # in one call: the lower halves of all parts, then the upper ones
        integrals_of_halves = integrate_parts(
            halves.integrand_number, halves.begin_place, halves.end_place
        )
        integrals_of_lower_halves, integrals_of_upper_halves = np.split(integrals_of_halves, 2)
        sums_of_halves = integrals_of_lower_halves + integrals_of_upper_halves
        changes_by_halving = np.abs(sums_of_halves - estimates_of_parts)

        is_final = (
            (changes_by_halving <= allowed_error_of_integrand[parts.integrand_number])
            | ~np.isfinite(changes_by_halving)
            | parts.are_halved_no_more(is_cut_at_place, len(integrals))
        )
        integrand_of_final_part = parts.integrand_number[is_final]
        np.add.at(integrals, integrand_of_final_part, sums_of_halves[is_final])
        np.add.at(errors, integrand_of_final_part, changes_by_halving[is_final])

        # Halves of parts that are not final are the parts of the next pass.
        numbers_of_next_halves = np.flatnonzero(np.tile(~is_final, 2))
        parts = halves.take(numbers_of_next_halves)
        estimates_of_parts = integrals_of_halves[numbers_of_next_halves]
    return IntegralsAndErrors(integrals, errors)


class _Parts(NamedTuple):
    """Parts of the ranges of integrands that are being halved, (n,) each.

    Attributes
    ----------
    integrand_number
        number of the integrand that the part belongs to
    begin_place, end_place
        ends of the part
    n_halvings
        number of halvings since the range was last cut at a place where the integrand is not smooth
    """

    integrand_number: Indices
    begin_place: Array
    end_place: Array
    n_halvings: NDArray[np.int64]

    def take(self, numbers: Indices) -> _Parts:
        """The parts with these numbers."""
        return _Parts(
            self.integrand_number[numbers],
            self.begin_place[numbers],
            self.end_place[numbers],
            self.n_halvings[numbers],
        )

    def are_halved_no_more(
        self, is_cut_at_place: NDArray[np.bool_], n_integrals: int
    ) -> NDArray[np.bool_]:
        """Which parts are left as they are, converged or not, (n,): those halved 17 times, and all
        where there are more than 64 parts for each integral and 256 besides. One that
        `is_cut_at_place` (n,), where the integrand is not smooth, counts as halved 0 times.
        """
        has_too_many_parts = (
            len(self.begin_place) > _MOST_PARTS_PER_INTEGRAL * n_integrals + _MOST_PARTS_BESIDES
        )
        is_halved_enough = (self.n_halvings == _MOST_HALVINGS) & ~is_cut_at_place
        return is_halved_enough | has_too_many_parts

    def halves(self, cut_of_parts: Array, is_cut_at_place: NDArray[np.bool_]) -> _Parts:
        """The parts below the cuts of all parts, then those above them, (2n,) each. Where a part is
        cut at a place at which the integrand is not smooth the halvings count from 0 again.
        """
        n_halvings = np.where(is_cut_at_place, -1, self.n_halvings) + 1
        return _Parts(
            np.tile(self.integrand_number, 2),
            np.r_[self.begin_place, cut_of_parts],
            np.r_[cut_of_parts, self.end_place],
            np.tile(n_halvings, 2),
        )


def _cuts_of_parts(parts: _Parts, cut_places: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Where each of n parts of a range of integration is cut, (n,), and whether at a place at which
    the integrand is not smooth, (n,).

    It is the place next above the middle, else the one below it, else the middle itself. A place
    close to an end, within 1/16 of the part, is not taken: a part of next to no length would change
    nothing. `cut_places` (j,) are such places, ascending, then infinity.
    """
    cut_of_part = (parts.begin_place + parts.end_place) / 2
    is_cut_at_place = np.zeros(len(cut_of_part), dtype=bool)
    index_of_place_above = np.searchsorted(cut_places, cut_of_part)
    least_length = (parts.end_place - parts.begin_place) / 16
    for nearest_place in (cut_places[index_of_place_above - 1], cut_places[index_of_place_above]):
        is_place_inside = (nearest_place > parts.begin_place + least_length) & (
            nearest_place < parts.end_place - least_length
        )
        cut_of_part = np.where(is_place_inside, nearest_place, cut_of_part)
        is_cut_at_place |= is_place_inside
    return cut_of_part, is_cut_at_place
