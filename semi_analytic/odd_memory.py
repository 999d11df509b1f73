"""Friction work that tilt and bulk strain of finite bodies add to that of half-planes: to the
second order in both, along the memory curve, without grids. For parabolas.

The tilt alpha = alpha_P P + alpha_Q Q and the bulk strain eps = e_P P + e_Q Q follow the loads. A
parabola of radius R then touches about -alpha R. They make tractions that are odd in x, so that the
load P_c at the stick edge is that of half-planes, and work has no first order in them. The memory
M(eta) at a load eta was set at an earlier instant m: when the contact grew in stick to eta, or at
the end of the stroke that slipped there. With sigma = dM/d eta there, s the direction of slip, ::

    N = f P - s Q,    a_s = f alpha - s eps,    mu = f - s sigma
    v = -R (a_s - a_s,m)/mu
    centre of contact  -alpha R,    centre of stick  -alpha_m R + v,    D their distance

f p - s q is the pressure of a frictionless contact under the load N and the tilt a_s. The work of a
cycle gains a sum over its slip:

1. while both edges slip one way,  f (-N' D^2/(2R) - a_s' D (P - P_c)) dt;
2. where the stick edge passes memory that was set in stick,
   -s f (P - P_c) (v^2 dsigma/d eta/(2R) + v (sigma dalpha_m/d eta - deps_m/d eta)) |dP_c|;
3. where it passes a kink of M, from mu_o and the centre d_o to mu_i and d_i,
   f (P - P_c) (d_o - d_i)^2 mu_o mu_i/(2R (mu_o - mu_i));
4. at a smooth end of a stroke, where N' = 0 at P = P_e: one side stops before the other and leaves
   tangential loads dT = R (a_s'^2/N'') T P_e/eta d eta on flat punches P_c < eta < P_e, with T of
   `stroke_end`. Their work is f (P_e - eta) dT, and f (P - eta) dT again when the stick edge of the
   next stroke passes eta.

' is d/dt. Each is a quadratic form of o = (alpha_P, alpha_Q, e_P, e_Q). Source: second order of
the odd part of Coulomb's problem, derived here. It is compared with grids, with closed forms, and
with an earlier version.

Refused by `DeclinedError`, with the reason: a cycle in which slip comes back to an earlier limit
under other loads and passes it (an inner loop that closes, or P that falls across a slip line of
M), contact that grows or shrinks along the limit of friction, gross sliding.

# notation: A = 2/E*, eta load in [0, P], M(eta) memory curve, P_c load at the stick edge, a contact
#           half-width, c stick half-width
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from scenes import NORMAL_LOAD, TANGENTIAL_LOAD, BodyEffects, Estimate, Hertz, Scene
from scenes.array_types import Array
from semi_analytic.elasticity import composite_modulus
from semi_analytic.history import History, Span, history_of, time_in_followed_path
from semi_analytic.memory import (
    Piece,
    combination_change,
    force_on_piece,
    instant,
    is_at_coulomb_limit,
    pieces,
    slip_combination,
    slip_combination_on_piece,
    time_of_load_on_arc,
)
from semi_analytic.stroke_end import loads_left_at_stroke_end

TILT_AND_STRAIN_NAMES = (
    "tilt_under_pressure",
    "tilt_under_shear",
    "strain_under_pressure",
    "strain_under_shear",
)
"""alpha_P, alpha_Q, e_P, e_Q among the fields of `BodyEffects`."""

# Points of Gauss' rule on a span, and panels of the loads that a smooth end of a stroke leaves:
# half as many give the error.
_GAUSS_POINTS = 24
_PANELS_OF_STROKE_END = 80
# A stroke ends smoothly where the rate of s Q - f P is below this fraction of its largest in the
# span.
_RATE_SHARE_AT_REST = 1e-6
# Fraction of the next order: see `SecondOrderWork.added_work`. Beyond the largest ratio grids
# differ from the second order by up to several times W.
_FACTOR_OF_NEXT_ORDER = 0.5
_LARGEST_ONE_SIDED_RATIO = 0.8
# Segments of a path at most: each takes a millisecond.
_MOST_SEGMENTS = 1000
# Step of a derivative of rates, over the duration of a segment or arc.
_DERIVATIVE_STEP = 1e-4
# Two loads, or two slopes, are equal within this fraction of the load, or of f.
_EQUALITY_TOLERANCE = 1e-9
# Below this c/a at the end of a stroke all but slides.
_LEAST_STICK_RATIO = 1e-3


@dataclass(frozen=True, eq=False)
class SecondOrderWork:
    """Friction work of a cycle that tilt and bulk strain add: o . matrix o, o = (alpha_P, alpha_Q,
    e_P, e_Q), their values per normal and per tangential load.

    Attributes
    ----------
    matrix
        (4, 4) symmetric [energy per thickness, over two of the numbers]; NaN where no matrix holds
    coarse_matrix
        that matrix by half as many quadrature points: the difference is the quadrature error
    one_sided_coefficients
        arrays (n, 4) of coefficients c at n instants, one for each span and criterion: where
        |c . o| > 1, one side of the contact slips alone
    reason_declined
        why there is no matrix; empty where there is one
    """

    matrix: Array
    coarse_matrix: Array
    one_sided_coefficients: tuple[Array, ...] = ()
    reason_declined: str = ""

    def added_work(self, tilt_and_strain_per_load: ArrayLike) -> Estimate:
        """Friction work that tilt and bulk strain add in a cycle, o . matrix o, with its
        uncertainty [energy per thickness]; o = (alpha_P, alpha_Q, e_P, e_Q), (4,).

        The uncertainty is the quadrature error plus that of the next order. The latter is half of r
        times the sum of the absolute terms of the quadratic form. r is the largest one-sided ratio;
        above 1 one side of the contact slips alone. Fitted to 500 random ellipses and polygons on
        grids: the true error was a third of the uncertainty at most, but once 0.99 of it.

        Raises
        ------
        DeclinedError
            Where there is no matrix, or where one side of the contact slips alone, or nearly so
            (a ratio above 0.8), through half of a span.
        """
        if self.reason_declined:
            raise DeclinedError(self.reason_declined)
        o = np.asarray(tilt_and_strain_per_load, dtype=float)
        # r; above 0.8 the second order is refused.
        one_sided_ratio = self.largest_one_sided_ratio(o)
        if one_sided_ratio > _LARGEST_ONE_SIDED_RATIO:
            raise DeclinedError(
                "tilt and strain go so fast that one side of the contact slips alone"
            )
        # coarse_matrix: by half as many quadrature points.
        added_work = float(o @ self.matrix @ o)
        quadrature_error = abs(added_work - float(o @ self.coarse_matrix @ o))
        sum_of_absolute_terms = float(np.abs(o) @ np.abs(self.matrix) @ np.abs(o))
        next_order_error = _FACTOR_OF_NEXT_ORDER * one_sided_ratio * sum_of_absolute_terms
        return Estimate(added_work, quadrature_error + next_order_error)

    def added_work_by_effects(self, effects_per_load: Sequence[Estimate]) -> Estimate:
        """Friction work that tilt and bulk strain add in a cycle, with its uncertainty [energy per
        thickness]. `effects_per_load` are alpha_P, alpha_Q, e_P and e_Q with their uncertainties.

        The uncertainty is that of `added_work`, plus that by the four numbers: 2 |o| . |matrix| d,
        d their uncertainties, o = (alpha_P, alpha_Q, e_P, e_Q). DeclinedError where `added_work`
        declines.
        """
        o = np.array([float(effect.value) for effect in effects_per_load])
        uncertainties = np.array([float(effect.uncertainty) for effect in effects_per_load])
        added_work = self.added_work(o)
        error_by_effects = 2 * float(np.abs(o) @ np.abs(self.matrix) @ uncertainties)
        return Estimate(added_work.value, added_work.uncertainty + error_by_effects)

    def largest_one_sided_ratio(self, tilt_and_strain_per_load: ArrayLike) -> float:
        """How nearly tilt and strain o make one side of the contact slip alone: the largest ratio
        |c . o| over the spans of slip and stick, each by its median in time.

        Above 1, one side slips alone through half of a span. c are coefficients (4,) at n instants
        of a span, rows of the arrays in `one_sided_coefficients`; o = (alpha_P, alpha_Q, e_P, e_Q).
        0 if no span has coefficients.
        """
        o = np.asarray(tilt_and_strain_per_load, dtype=float)
        median_ratios = [
            float(np.median(np.abs(coefficients @ o)))
            for coefficients in self.one_sided_coefficients
        ]
        return max(median_ratios, default=0.0)


class DeclinedError(Exception):
    """The second order in tilt and strain does not hold: for a history, or for values so large."""


@dataclass(frozen=True, eq=False)
class SecondOrderAnswer:
    """What tilt and bulk strain of the bodies change in a half-plane contact along a load path.

    Attributes
    ----------
    history
        stick and slip of the half-planes along the path
    radius
        R of the parabola [length]
    tilt_and_strain_per_load
        (alpha_P, alpha_Q, e_P, e_Q), (4,) [thickness per force]
    works
        friction work that they add in each cycle up to the steady one, or in a path without cycle;
        with the uncertainty of `SecondOrderWork.added_work` and of these values [energy per
        thickness]
    """

    history: History
    radius: float
    tilt_and_strain_per_load: Array
    works: tuple[Estimate, ...]

    def centres(self, time: Array) -> tuple[Array, Array]:
        """Centres of the contact and of the stick zone at times (n,) of the path, (n,) each, along
        x from the axis of the profile [length]: to the first order in tilt and bulk strain.

        Without tilt and strain both are at 0. The second is NaN where all of the contact slips.
        Each time is looked up in the span of stick or slip that it falls in; later ones are moved
        back by whole periods.
        """
        # Spans of full stick or of slip in one direction; `delay`: whole periods by which a span is
        # later than its load segment; begin and end are instants on that segment.
        spans = self.history.spans
        ends_of_spans = np.array([span.end.time + span.delay for span in spans])
        start_time = spans[0].begin.time + spans[0].delay
        # Times within the followed path; slack: what round-off may leave beyond its ends.
        path_time, slack = time_in_followed_path(
            time, float(start_time), float(ends_of_spans[-1]), self.history.period
        )
        span_numbers = np.minimum(
            np.searchsorted(ends_of_spans, path_time - slack, side="left"), len(spans) - 1
        )
        contact_centres = np.zeros(len(time))
        stick_centres = np.zeros(len(time))
        for span_number in np.unique(span_numbers):
            span = spans[span_number]
            # Coefficients (n, 4) of the centres, to be multiplied by (alpha_P, alpha_Q, e_P, e_Q).
            is_inside = span_numbers == span_number
            times_in_segment = np.clip(
                path_time[is_inside] - span.delay, span.begin.time, span.end.time
            )
            contact_coefficients, stick_coefficients = centre_coefficients(
                span, self.radius, times_in_segment
            )
            contact_centres[is_inside] = contact_coefficients @ self.tilt_and_strain_per_load
            stick_centres[is_inside] = stick_coefficients @ self.tilt_and_strain_per_load
        return contact_centres, stick_centres


def second_order_answer(scene: Scene, effects: BodyEffects) -> SecondOrderAnswer:
    """Friction work that tilt and bulk strain of finite bodies add in each cycle of a scene up to
    the steady one, to the second order in both.

    With it comes the history of stick and slip, which gives the centres of contact and stick.
    At most as many cycles are followed as the scene has, but two where it has one. Of a path
    without cycles there is one work, that of all of it.

    Tilt and strain make tractions that are odd in x, so that work has no first order in them. It is
    a quadratic form of the tilt and the strain per load, which are among the `effects`. Stick and
    slip are those of half-planes along the load path.

    Raises
    ------
    DeclinedError
        For profiles other than a parabola, unlike materials, paths of more than 1000 segments;
        where the second order does not hold.
    """
    radius = _radius_of_parabola(scene)
    if effects.dundurs_beta:
        raise DeclinedError(
            "the materials are unlike, and tilt and strain count in the first order"
        )
    path = scene.load.path()
    n_segments = len(path.initial_loading) + len(path.cycle)
    if n_segments > _MOST_SEGMENTS:
        raise DeclinedError(f"the path has {n_segments} segments, more than {_MOST_SEGMENTS}")

    # Two cycles at least: the first may differ from the steady one.
    history = history_of(path, scene.friction.coefficient, max(scene.cycles, 2))
    modulus = composite_modulus(scene.material)  # E*
    # TILT_AND_STRAIN_NAMES: alpha_P, alpha_Q, e_P, e_Q among the attributes of the effects.
    effects_per_load = [getattr(effects, name) for name in TILT_AND_STRAIN_NAMES]
    # Of each cycle its spans of stick or slip, and the spans next to it.
    works = tuple(
        second_order_work(spans, radius, modulus, span_before, next_span).added_work_by_effects(
            effects_per_load
        )
        for spans, span_before, next_span in _cycles_with_neighbours(history)
    )
    values_per_load = np.array([float(effect.value) for effect in effects_per_load])
    return SecondOrderAnswer(history, radius, values_per_load, works)


def _radius_of_parabola(scene: Scene) -> float:
    """R of the scene's profile [length]; DeclinedError for a profile other than a parabola."""
    profile = scene.profile
    if not isinstance(profile, Hertz):
        raise DeclinedError("the second order is known of a parabola")
    return profile.radius


def _cycles_with_neighbours(
    history: History,
) -> Iterator[tuple[tuple[Span, ...], Span | None, Span | None]]:
    """For each cycle of a history, or the whole path where it does not repeat: its spans of stick
    and slip, the span before them and the span after them, None where there is none.

    The steady cycle comes before and after itself.

    `history.loading` are the spans of the initial loading, `history.cycles` those of each cycle.
    `history.steady_from` is the index of the first cycle that repeats itself, if `history.repeats`.
    """
    earlier_spans = history.loading
    for cycle_index, spans in enumerate(history.cycles):
        span_before = earlier_spans[-1] if earlier_spans else None
        next_span = spans[0] if history.repeats else None
        if history.repeats and cycle_index == history.steady_from:
            span_before = spans[-1]
        elif cycle_index + 1 < len(history.cycles):
            next_span = history.cycles[cycle_index + 1][0]
        yield spans, span_before, next_span
        earlier_spans = spans


def second_order_work(
    spans: Sequence[Span],
    radius: float,
    modulus: float,
    span_before: Span | None,
    next_span: Span | None,
) -> SecondOrderWork:
    """Friction work that tilt and bulk strain add in a cycle, or in a whole path: quadratic form
    over o = (alpha_P, alpha_Q, e_P, e_Q), their values per normal and per tangential load.

    They make tractions that are odd in x, so that work has no first order in them. The matrix is
    taken with all points of the quadrature and with half of them. Where no matrix holds it is NaN,
    with the reason. The form holds while both sides of the contact slip alike: criteria come with
    it.

    Parameters
    ----------
    spans
        parts of the cycle, or of the path, in full stick or with slip in one direction
    radius, modulus
        R of the parabola, E*
    span_before, next_span
        the spans before and after these; of a steady cycle its last and its first span

    Returns
    -------
    SecondOrderWork
        both matrices (4, 4), work = o . matrix o; the criteria; the reason where there is no matrix
    """
    # _GAUSS_POINTS: 24 quadrature points of a span; _PANELS_OF_STROKE_END: 80 panels of the slip
    # zone at the smooth end of a stroke.
    spans_of_cycle = _SpansOfCycle(tuple(spans), radius, span_before, next_span)
    try:
        spans_of_cycle.require_no_limit_in_stick()
        fine_matrix = spans_of_cycle.matrix(_GAUSS_POINTS, _PANELS_OF_STROKE_END)
        coarse_matrix = spans_of_cycle.matrix(_GAUSS_POINTS // 2, _PANELS_OF_STROKE_END // 2)
    except DeclinedError as reason:
        unknown_matrix = np.full((4, 4), np.nan)
        return SecondOrderWork(unknown_matrix, unknown_matrix, reason_declined=str(reason))
    # Coefficients (n, 4) of o: where their product with o exceeds 1, one side slips alone.
    arrays_of_coefficients = [
        coefficients
        for span in spans
        for coefficients in _one_sided_slip_coefficients(span, radius, modulus)
    ]
    return SecondOrderWork(fine_matrix, coarse_matrix, tuple(arrays_of_coefficients))


def centre_coefficients(span: Span, radius: float, time: Array) -> tuple[Array, Array]:
    """Centres of contact and of the stick zone of a parabola at times (n,) of a span, to the first
    order, as coefficients (n, 4) each: the place is c . (alpha_P, alpha_Q, e_P, e_Q) [length].

    The four are tilt and bulk strain per normal and per tangential load. In full stick both centres
    are one; the second is NaN where all of the contact slips. `radius` is R of the parabola.

    A span is in full stick (direction 0) or slips in one direction. `span.sticking_piece` is the
    piece of the memory curve on which the stick edge lies, None in full slip.
    """
    normal_load, tangential_load = span.segment.loads(time)
    contact_coefficients = -radius * _tilt_coefficients(normal_load, tangential_load)
    if not span.direction:
        return contact_coefficients, contact_coefficients
    if span.sticking_piece is None:
        return contact_coefficients, np.full(contact_coefficients.shape, np.nan)
    stick_edge = _stick_edge_at(span, span.sticking_piece, time, span.slip_zone_load(time), radius)
    return contact_coefficients, contact_coefficients + stick_edge.centre_distance(radius)


@dataclass(frozen=True, eq=False)
class _SpansOfCycle:
    """The spans of stick and slip of one cycle, or of a whole path, on a parabola.

    Attributes
    ----------
    spans
        in the order of time, each in full stick or with slip in one direction
    radius
        R of the parabola [length]
    span_before, next_span
        the spans just before and just after the cycle, None where there is none
    """

    spans: tuple[Span, ...]
    radius: float
    span_before: Span | None
    next_span: Span | None

    def matrix(self, n_points: int, n_panels: int) -> Array:
        """Symmetric matrix (4, 4) of the friction work that tilt and bulk strain add, over o =
        (alpha_P, alpha_Q, e_P, e_Q), their values per normal and per tangential load: work = o .
        matrix o.

        It is the sum over all spans of slip, the kinks of the memory curve M(eta) that their stick
        edges pass, and the smooth ends of strokes. M(eta) is the tangential force of the flat
        punches up to the load eta.

        A smooth end, where the rates of the loads do not jump, leaves tangential loads in the slip
        zone; the stick edge of a later stroke passes them.

        Parameters
        ----------
        n_points
            number of quadrature nodes of a span
        n_panels
            number of panels into which the slip zone at a smooth end is divided

        Raises
        ------
        DeclinedError
            Where no matrix holds.
        """
        # Each span with the one before and the one after it. Each term of the sum is such a matrix,
        # zero where it does not apply.
        work_matrix = np.zeros((4, 4))
        spans_and_neighbours = (self.span_before, *self.spans, self.next_span)
        for span_before, span, next_span in zip(
            spans_and_neighbours[:-2], self.spans, spans_and_neighbours[2:], strict=True
        ):
            # +1 forward slip, -1 reverse slip, 0 full stick.
            if not span.direction:
                continue
            # DeclinedError where slip comes back to an earlier limit under other loads.
            if span_before is not None:
                _refuse_return_to_limit(span_before, span, self.radius)
                work_matrix += _work_at_kink(span_before, span, self.radius)
            work_matrix += _work_in_span(span, self.radius, n_points)
            work_matrix += _work_at_passed_end(span, self.radius, n_panels)
            # The stroke of slip ends with this span.
            if next_span is None or next_span.direction != span.direction:
                work_matrix += _work_at_stroke_end(span, self.radius, n_panels)
        return work_matrix

    def require_no_limit_in_stick(self) -> None:
        """Raise DeclinedError where P changes in full stick along the Coulomb limit, dQ = +-f dP.
        Tilt and strain make one side of the contact slip there.

        It concerns spans of full stick, direction 0, whose `sticking_piece` of the memory curve is
        a line of slope f or -f.
        """
        for span in self.spans:
            piece = span.sticking_piece
            # begin and end: instants at the ends of the span, with their loads.
            if span.direction or piece is None or span.begin.normal_load == span.end.normal_load:
                continue
            # Whether the slope of the memory curve on this piece is f or -f.
            if _is_set_by_slip(piece, span.friction):
                raise DeclinedError("P and Q go along the limit of friction, where one side slips")


# ----------------------------------------- tilt and strain by (alpha_P, alpha_Q, e_P, e_Q)
def _tilt_coefficients(normal_load: ArrayLike, tangential_load: ArrayLike) -> Array:
    """Tilt alpha at loads P and Q (n,), as coefficients (n, 4) of (alpha_P, alpha_Q, e_P, e_Q)."""
    zero = np.zeros(np.shape(normal_load))
    return np.stack([np.asarray(normal_load), np.asarray(tangential_load), zero, zero], axis=-1)


def _strain_coefficients(normal_load: ArrayLike, tangential_load: ArrayLike) -> Array:
    """Bulk strain eps at loads P and Q (n,), as coefficients (n, 4) of (alpha_P, alpha_Q, e_P,
    e_Q).
    """
    zero = np.zeros(np.shape(normal_load))
    return np.stack([zero, zero, np.asarray(normal_load), np.asarray(tangential_load)], axis=-1)


def _equivalent_tilt_coefficients(
    friction: float, direction: int, normal_load: ArrayLike, tangential_load: ArrayLike
) -> Array:
    """a_s = f alpha - s eps at loads P and Q (n,), as coefficients (n, 4) of (alpha_P, alpha_Q,
    e_P, e_Q); s is the `direction` of slip.

    f p - s q is the pressure of a frictionless contact under the load f P - s Q and this tilt.

    alpha is the tilt, eps the bulk strain: alpha = alpha_P P + alpha_Q Q, eps = e_P P + e_Q Q.
    """
    return friction * _tilt_coefficients(
        normal_load, tangential_load
    ) - direction * _strain_coefficients(normal_load, tangential_load)


def _quadratic_form(weights: Array, left_coefficients: Array, right_coefficients: Array) -> Array:
    """Symmetric matrix (4, 4) of the sum over n of weight (left . o) (right . o): weights (n,),
    vectors (n, 4).
    """
    form = np.einsum("n,ni,nj->ij", weights, left_coefficients, right_coefficients)
    return np.asarray((form + form.T) / 2)


# -------------------------------------------------------------------------- stick edges in a span
@dataclass(frozen=True, eq=False)
class _StickEdge:
    """The stick edge on one piece of the memory curve M(eta), at instants (n,).

    Attributes
    ----------
    load
        P, (n,) [force per thickness]
    slip_zone_load
        P - P_c, (n,), P_c the load at the stick edge
    steepness
        mu = f - s M' at P_c, (n,), s the direction of slip
    loads_since_set
        P and Q minus those at which the memory at P_c was set, (n,) each
    centre_shift
        v, shift of the centre of stick since then, as coefficients (n, 4) of (alpha_P, alpha_Q,
        e_P, e_Q) [length]
    """

    load: Array
    slip_zone_load: Array
    steepness: Array
    loads_since_set: tuple[Array, Array]
    centre_shift: Array

    def centre_distance(self, radius: float) -> Array:
        """D, the centre of stick minus that of contact, as coefficients (n, 4) of (alpha_P,
        alpha_Q, e_P, e_Q) [length]; `radius` is R of the parabola.
        """
        return np.asarray(radius * _tilt_coefficients(*self.loads_since_set) + self.centre_shift)


def _stick_edge_at(
    span: Span, memory_piece: Piece, time: Array, slip_zone_load: Array, radius: float
) -> _StickEdge:
    """The stick edge at times (n,) of a span of slip: steepness of the memory curve there, and how
    P, Q and the centre of stick have changed since the memory was set there.

    The load at the edge, P_c = P - `slip_zone_load` (n,), lies on the `memory_piece`. The memory
    curve M(eta) is the tangential force of the flat punches up to the load eta. It was
    set at P_c in stick when P grew to P_c, or by slip at the end of a stroke; m is that instant.
    Since then tilt and strain shift the centre of stick by v = -R (a_s - a_s,m)/mu. a_s = f alpha -
    s eps, mu = f - s M' is the steepness, s the direction of slip, R the `radius` of the parabola.

    # notation: alpha tilt, eps bulk strain under the loads at that instant, f friction coefficient
    """
    # P at these times, M' at P_c, and mu.
    normal_load = span.segment.loads(time)[0]
    memory_slope = memory_piece.slope_at(normal_load - slip_zone_load)
    steepness = span.friction - span.direction * memory_slope
    # combination_change: change of P, or of Q, since the instant `anchor` at which slip ended.
    if _is_set_by_slip(memory_piece, span.friction):
        loads_since_set = (
            combination_change(memory_piece.anchor, span.segment, NORMAL_LOAD, time),
            combination_change(memory_piece.anchor, span.segment, TANGENTIAL_LOAD, time),
        )
    else:
        # It was set at P = P_c, Q = M(P_c), and s M(P_c) - f P_c is s Q - f P now.
        tangential_load_since_set = span.direction * span.friction * slip_zone_load
        loads_since_set = (slip_zone_load, tangential_load_since_set)
    equivalent_tilt_since_set = _equivalent_tilt_coefficients(
        span.friction, span.direction, *loads_since_set
    )
    centre_shift = -radius * equivalent_tilt_since_set / steepness[:, None]
    return _StickEdge(normal_load, slip_zone_load, steepness, loads_since_set, centre_shift)


def _is_set_by_slip(memory_piece: Piece, friction: float) -> bool:
    """Whether slip set the memory of a piece, at the end of a stroke: then it is at the Coulomb
    limit, M' = f or -f. Otherwise it was set while the contact grew in stick.
    """
    return is_at_coulomb_limit(memory_piece, 1, friction) or is_at_coulomb_limit(
        memory_piece, -1, friction
    )


def _loads_when_set(memory_piece: Piece, friction: float, eta: Array) -> tuple[Array, Array]:
    """P and Q at the instants at which the memory at loads eta (n,) of a piece was set, (n,) each:
    those of its anchor if slip set it, else eta and M(eta).
    """
    if _is_set_by_slip(memory_piece, friction):
        ones = np.ones(np.shape(eta))
        return memory_piece.anchor.normal_load * ones, memory_piece.anchor.tangential_load * ones
    return eta, force_on_piece(memory_piece, eta)


def _slope_derivative(memory_piece: Piece, eta: Array) -> Array:
    """Derivative d2M/d eta2 of the slope M' of a piece of the memory curve, at loads eta
    (n,) [thickness per force].

    It is constant on a straight or parabolic piece. On an arc M' = dQ/dP of the load path, and it
    is found by central differences in time; it is 0 on an arc without duration, which round-off may
    leave. The memory curve M(eta) is the tangential force of the flat punches up to the load eta.
    """
    if memory_piece.arc_times is None:
        # bend: half of d2M/d eta2.
        return np.full(np.shape(eta), 2 * memory_piece.bend)
    # arc_times: times of both ends of the arc on the load segment that was passed in stick
    first_time, last_time = memory_piece.arc_times
    if first_time == last_time:
        return np.zeros(np.shape(eta))
    segment = memory_piece.anchor.segment
    # Times at which P was eta on the arc, and Q'/P' a little before and after them.
    time = time_of_load_on_arc(memory_piece, eta)
    # _DERIVATIVE_STEP: 1e-4 of the duration of the arc.
    time_increment = _DERIVATIVE_STEP * (last_time - first_time)
    slopes = []
    for shifted_time in (time - time_increment, time + time_increment):
        normal_rate, tangential_rate = segment.rates(shifted_time)
        slopes.append(tangential_rate / normal_rate)
    slope_before, slope_after = slopes
    normal_rate, _ = segment.rates(time)
    return np.asarray((slope_after - slope_before) / (2 * time_increment * normal_rate))


# ---------------------------------------------------------------------------------- terms of work
def _gauss_times(span: Span, n_points: int) -> tuple[Array, Array]:
    """Times of Gauss' rule in a span, and their weights in time, (n_points,) each."""
    nodes, weights = np.polynomial.legendre.leggauss(n_points)
    half_duration = (span.end.time - span.begin.time) / 2
    return span.begin.time + half_duration * (1 + nodes), half_duration * weights


def _work_in_span(span: Span, radius: float, n_points: int) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add while both edges of contact slip
    in one direction s, in a span of time: work = o . matrix o, o = (alpha_P, alpha_Q, e_P, e_Q).

        int f (-N' D^2/(2R) - a_s' D (P - P_c)) dt,    N = f P - s Q,    a_s = f alpha - s eps

    and, where the stick edge passes memory that was set in stick, what `_work_along_memory` gives.
    ' is d/dt; alpha = alpha_P P + alpha_Q Q is the tilt, eps = e_P P + e_Q Q the bulk strain. P_c
    is the load at the stick edge, D the centre of stick minus that of contact.

    The integrals are taken by Gauss' rule of `n_points` nodes in time; `radius` is R of the
    parabola. DeclinedError where the contact slides as a whole.
    """
    piece_at_stick_edge = span.sticking_piece  # of the memory curve, where the stick edge is
    if piece_at_stick_edge is None:
        raise DeclinedError("the contact slides as a whole")
    time, time_weights = _gauss_times(span, n_points)

    # P - P_c; then the steepness mu = f - s dM/d eta of the memory curve at the stick edge, (n,), D
    # and v, how far the centre of stick has moved since the memory was set, (n, 4).
    slip_zone_load = span.slip_zone_load(time)
    stick_edge = _stick_edge_at(span, piece_at_stick_edge, time, slip_zone_load, radius)
    s_q_minus_f_p = slip_combination(span.direction, span.friction)  # -N
    rate_of_s_q_minus_f_p = np.asarray(span.segment.rate_of(s_q_minus_f_p, time))  # -N'
    rate_of_a_s = _equivalent_tilt_coefficients(
        span.friction, span.direction, *span.segment.rates(time)
    )
    centre_distance = stick_edge.centre_distance(radius)
    friction_times_weights = span.friction * time_weights
    work_matrix = _quadratic_form(
        friction_times_weights * rate_of_s_q_minus_f_p / (2 * radius),
        centre_distance,
        centre_distance,
    )
    work_matrix = work_matrix - _quadratic_form(
        friction_times_weights * slip_zone_load, rate_of_a_s, centre_distance
    )
    if _is_set_by_slip(piece_at_stick_edge, span.friction):
        return work_matrix
    # s f (P - P_c) |dP_c|, since P_c falls by -N' dt/mu
    weights_along_memory = (
        span.direction
        * friction_times_weights
        * slip_zone_load
        * rate_of_s_q_minus_f_p
        / stick_edge.steepness
    )
    work_by_bend, work_by_tilt = _work_along_memory(
        piece_at_stick_edge, stick_edge, weights_along_memory, radius
    )
    return work_matrix - work_by_bend - work_by_tilt


def _work_along_memory(
    memory_piece: Piece, stick_edge: _StickEdge, weights: Array, radius: float
) -> tuple[Array, Array]:
    """Two matrices (4, 4) over o = (alpha_P, alpha_Q, e_P, e_Q), tilt and strain per load: friction
    work, to be subtracted, where the stick edge passes a piece of memory that was set in
    stick.

        int s f (P - P_c) v^2 d2M/d eta2/(2R) |dP_c|,
        int s f (P - P_c) v (dM/d eta dalpha/d eta - deps/d eta) |dP_c|

    The memory M(eta) is the tangential force of the flat punches up to the load eta. The growing
    contact set it in stick, at P = eta and Q = M(eta): the derivatives by eta are of the tilt alpha
    and the bulk strain eps at these loads. v (`centre_shift`) is how far tilt and strain have
    shifted the centre of stick since the memory at P_c was set.

    `stick_edge` has P, P - P_c and v at n instants, P_c the load at the stick edge. `weights` (n,)
    are s f (P - P_c) |dP_c|, s the direction of slip. `radius` is R of the parabola.
    """
    eta = stick_edge.load - stick_edge.slip_zone_load
    memory_slope = memory_piece.slope_at(eta)
    unit_load_rate = np.ones(np.shape(eta))  # dP/d eta along the memory; dQ/d eta is its slope
    tilt_by_eta = _tilt_coefficients(unit_load_rate, memory_slope)
    strain_by_eta = _strain_coefficients(unit_load_rate, memory_slope)
    # dM/d eta dalpha/d eta - deps/d eta
    equivalent_tilt_by_eta = memory_slope[:, None] * tilt_by_eta - strain_by_eta
    work_by_bend = _quadratic_form(
        weights * _slope_derivative(memory_piece, eta) / (2 * radius),
        stick_edge.centre_shift,
        stick_edge.centre_shift,
    )
    work_by_tilt = _quadratic_form(weights, stick_edge.centre_shift, equivalent_tilt_by_eta)
    return work_by_bend, work_by_tilt


def _work_at_kink(span_before: Span, span: Span, radius: float) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add where the stick edge passes a
    kink of the memory curve, over (alpha_P, alpha_Q, e_P, e_Q). At a kink the slope M' jumps.

        f (P - P_c) (d_o - d_i)^2 mu_o mu_i/(2R (mu_o - mu_i))

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. d is the
    centre of stick and mu the steepness f - s M' on the outer (o) and the inner (i) side of the
    kink, s the direction of slip. P_c is the load at the stick edge, which then is that of the
    kink. Zero where no kink is passed between the two spans. `radius` is R of the parabola.
    """
    zero_matrix = np.zeros((4, 4))
    pieces_at_kink = _pieces_at_kink(span_before, span)
    if pieces_at_kink is None:
        return zero_matrix

    outer_piece, _ = pieces_at_kink
    # At the instant at which the edge passes the kink, (1,).
    time_of_passage = np.array([span.begin.time])
    slip_zone_load = span.begin.normal_load - np.array([outer_piece.bottom_load])
    eta = np.array([outer_piece.bottom_load])
    stick_centres = []
    steepness_of_sides = []
    for memory_piece in pieces_at_kink:
        # Shift of the centre since the memory was set there, and the centre at that time.
        stick_edge = _stick_edge_at(span, memory_piece, time_of_passage, slip_zone_load, radius)
        centre_when_set = -radius * _tilt_coefficients(
            *_loads_when_set(memory_piece, span.friction, eta)
        )
        stick_centres.append(centre_when_set + stick_edge.centre_shift)
        steepness_of_sides.append(float(stick_edge.steepness[0]))

    # mu_o and mu_i, then mu_o - mu_i and mu_o mu_i.
    outer_steepness, inner_steepness = steepness_of_sides
    steepness_jump = outer_steepness - inner_steepness
    steepness_product = outer_steepness * inner_steepness
    # _EQUALITY_TOLERANCE: 1e-9 of f, within which two slopes are equal.
    if abs(steepness_jump) <= _EQUALITY_TOLERANCE * span.friction or steepness_product <= 0:
        return zero_matrix
    outer_centre, inner_centre = stick_centres
    centre_jump = outer_centre - inner_centre
    weight = span.friction * slip_zone_load * steepness_product / (2 * radius * steepness_jump)
    return _quadratic_form(weight, centre_jump, centre_jump)


def _pieces_at_kink(span_before: Span, span: Span) -> tuple[Piece, Piece] | None:
    """The two pieces of the memory curve, outer and inner, between which the stick edge passes from
    one span of slip to the next; None where it passes no kink of the curve.

    There is none where the spans slip in different directions, where nothing sticks in one of them,
    and where the edge is on one piece in both. Pieces at the Coulomb limit between the two are
    passed at once: they count as one kink.
    """
    outer_piece = span_before.sticking_piece
    inner_piece = span.sticking_piece
    if span_before.direction != span.direction or outer_piece is None or inner_piece is None:
        return None

    # bottom_load and top_load: loads eta at both ends of a piece.
    # _EQUALITY_TOLERANCE: 1e-9 of a load, within which two loads are equal.
    load_tolerance = _EQUALITY_TOLERANCE * outer_piece.top_load
    if inner_piece.top_load > outer_piece.bottom_load + load_tolerance:
        return None  # both spans are on one piece
    if inner_piece.top_load - inner_piece.bottom_load <= load_tolerance:
        return None  # the stick edge stays at the upper end of a piece at the Coulomb limit
    return outer_piece, inner_piece


def _refuse_return_to_limit(span_before: Span, span: Span, radius: float) -> None:
    """Refuse a load path on which slip returns, under other loads, to where an earlier stroke in
    the same direction ended: then the work by tilt and strain has no second-order form.

    The stick edge of a `span` of slip then passes a piece of the memory curve that the earlier
    stroke has left at the Coulomb limit. The path is refused if P and Q differ from those at the
    end of that stroke. It is refused too if that end was smooth, without a jump of the rates of the
    loads: tangential loads that are left there would be passed. `span_before` ends where the `span`
    begins; `radius` is R of the parabola.

    Raises
    ------
    DeclinedError
        If the loads differ, or the end was smooth.
    """
    # Pieces of the memory curve M(eta) at the end of the span before, from the outside inwards.
    friction = span.friction
    begin = span.begin
    top_of_sticking_piece = span.sticking_piece.top_load if span.sticking_piece is not None else 0.0
    for memory_piece in pieces(span_before.curve(span_before.end.time)):
        # _EQUALITY_TOLERANCE: 1e-9 of a load.
        load_tolerance = _EQUALITY_TOLERANCE * max(
            memory_piece.anchor.normal_load, begin.normal_load
        )
        if memory_piece.bottom_load < top_of_sticking_piece - load_tolerance:
            break
        # A piece without length leaves nothing to return to.
        has_no_length = memory_piece.top_load - memory_piece.bottom_load <= load_tolerance
        if has_no_length or not is_at_coulomb_limit(memory_piece, span.direction, friction):
            continue
        # anchor: instant at which the earlier stroke ended and left this piece.
        normal_change = begin.normal_load - memory_piece.anchor.normal_load
        tangential_change = begin.tangential_load - memory_piece.anchor.tangential_load
        # None at a vertex of the path; `tilt_rate_form` is 0 if nothing is left there.
        earlier_smooth_end = _smooth_end_at_anchor(memory_piece, span.direction, friction, radius)
        if (
            abs(normal_change) > load_tolerance
            or abs(tangential_change) > friction * load_tolerance
        ):
            raise DeclinedError("slip comes back to an earlier limit under other loads")
        if earlier_smooth_end is not None and np.any(earlier_smooth_end.tilt_rate_form):
            raise DeclinedError("slip goes on after a smooth end of its stroke")


@dataclass(frozen=True, eq=False)
class _SmoothEnd:
    """The smooth end of a stroke of slip: the rate of s Q - f P vanishes there.

    Attributes
    ----------
    load, stick_edge_load
        P and the load P_c at the stick edge, at that instant [force per thickness]
    tilt_rate_form
        R a_s'^2/N'' as a matrix (4, 4) over (alpha_P, alpha_Q, e_P, e_Q)
    """

    load: float
    stick_edge_load: float
    tilt_rate_form: Array

    def remaining_loads(self, n_panels: int) -> tuple[Array, Array]:
        """Tangential loads that the smooth end of a stroke leaves on flat punches: loads eta (n,)
        of the punches, and what is left next to each, divided by R a_s'^2/N'', (n,).

        At such an end one side of the contact stops before the other. What this leaves is dT =
        (R a_s'^2/N'') T P/eta d eta, with a tabulated function T of eta. `n_panels` divide P_c <
        eta < P, where `load` is P and `stick_edge_load` P_c, the load at the stick edge.

        Raises
        ------
        DeclinedError
            Where almost nothing sticks, c/a below 1e-3.

        # notation: a, c half-widths of contact and stick, N'' second rate of f P - s Q, a_s' rate
        #           of f alpha - s eps, s direction of slip, alpha tilt, eps bulk strain, R radius
        #           of the parabola
        """
        stick_ratio = float(np.sqrt(self.stick_edge_load / self.load))
        if stick_ratio < _LEAST_STICK_RATIO:
            raise DeclinedError("all but the middle of the contact slides")
        # Panels of the half-width b of the punches between c and a, over a, and T on each.
        panels = loads_left_at_stroke_end(stick_ratio, n_panels)
        eta = self.load * panels.punch_half_width**2
        # d eta/eta is 2 db/b
        return eta, 2 * self.load * panels.load_left * panels.panel_width / panels.punch_half_width


def _smooth_end(
    span: Span, time: float, stick_edge_load: float, radius: float
) -> _SmoothEnd | None:
    """The smooth end of a stroke of slip in the direction s, at a `time` of the load segment of a
    span; None where the stroke ends at a vertex of the load path, or nothing has slipped.

    At a smooth end the rate of s Q - f P vanishes and changes its sign. Slip stops without a jump
    of the rates of the loads. `stick_edge_load` is P_c there, the load at the stick edge; `radius`
    is R of the parabola. s is the `direction` of the span.

    # notation: a_s' rate of f alpha - s eps, alpha tilt, eps bulk strain
    """
    segment = span.segment
    s_q_minus_f_p = slip_combination(span.direction, span.friction)
    time_in_middle = (span.begin.time + span.end.time) / 2
    # Rates of s Q - f P; `time` is taken as the end of the stroke.
    rate_at_begin, rate_in_middle, rate_at_end = (
        abs(float(segment.rate_of(s_q_minus_f_p, rate_time)))
        for rate_time in (span.begin.time, time_in_middle, time)
    )
    largest_rate = max(rate_at_begin, rate_in_middle, rate_at_end)
    normal_load_at_end = float(segment.loads(time)[0])
    # _RATE_SHARE_AT_REST: 1e-6 of the largest rate; _EQUALITY_TOLERANCE: 1e-9 of the load.
    if rate_at_end > _RATE_SHARE_AT_REST * largest_rate or stick_edge_load >= normal_load_at_end * (
        1 - _EQUALITY_TOLERANCE
    ):
        return None
    # Second rate by a difference of rates around the end, with 1e-4 of the segment's duration.
    time_increment = _DERIVATIVE_STEP * (segment.end - segment.start)
    rate_after = float(segment.rate_of(s_q_minus_f_p, time + time_increment))
    rate_before = float(segment.rate_of(s_q_minus_f_p, time - time_increment))
    second_rate = (rate_before - rate_after) / (2 * time_increment)  # N'', of N = f P - s Q
    if second_rate <= 0:
        return None
    # a_s' = f alpha' - s eps', as coefficients (4,) of (alpha_P, alpha_Q, e_P, e_Q).
    rate_of_a_s = _equivalent_tilt_coefficients(span.friction, span.direction, *segment.rates(time))
    return _SmoothEnd(
        normal_load_at_end,
        stick_edge_load,
        radius / second_rate * np.outer(rate_of_a_s, rate_of_a_s),
    )


def _smooth_end_at_anchor(
    memory_piece: Piece, direction: int, friction: float, radius: float
) -> _SmoothEnd | None:
    """The smooth end of the stroke of slip that left a piece of the memory curve at the
    Coulomb limit; None where that stroke ended at a vertex of the load path.

    At a smooth end the rates of the loads do not jump. `piece.anchor` is the instant at which the
    stroke ended, `piece.bottom_load` the load at its stick edge; `direction` is that of its slip.
    """
    end_of_stroke = memory_piece.anchor
    # That stroke, as a span of slip from the start of the load segment to its end.
    start = instant(end_of_stroke.segment, end_of_stroke.segment.start)
    stroke = Span(start, end_of_stroke, 0.0, direction, None, friction)
    return _smooth_end(stroke, end_of_stroke.time, memory_piece.bottom_load, radius)


def _work_at_stroke_end(span: Span, radius: float, n_panels: int) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add at the smooth end of a stroke,
    over (alpha_P, alpha_Q, e_P, e_Q); zero where the end is not smooth.

    The stroke ends with the `span` of slip. At a smooth end the rates of the loads do not jump.
    alpha_P, alpha_Q are tilts of the faces by unit loads P and Q, e_P, e_Q bulk strains. The two
    sides of the slip zone stop one after the other, which leaves tangential loads dT on flat
    punches at loads eta. Their work is f int (P - eta) dT. `n_panels` are those of this integral;
    `radius` is R of the parabola.

    # notation: N'' second rate of f P - s Q, a_s' rate of f alpha - s eps there, alpha tilt, eps
    #           bulk strain, s direction of slip
    """
    stick_edge_load = span.end.normal_load - float(span.slip_zone_load(span.end.time))
    # None where the stroke ends at a vertex of the load path.
    smooth_end = _smooth_end(span, span.end.time, stick_edge_load, radius)
    if smooth_end is None:
        return np.zeros((4, 4))
    # Loads eta of punches, and the tangential load left next to each over R a_s'^2/N'';
    # tilt_rate_form is R a_s'^2/N'' as a quadratic form of tilt and strain.
    eta, tangential_load_left = smooth_end.remaining_loads(n_panels)
    integral_of_load_left = float(np.sum(tangential_load_left * (smooth_end.load - eta)))
    return np.asarray(span.friction * integral_of_load_left * smooth_end.tilt_rate_form)


def _work_at_passed_end(span: Span, radius: float, n_panels: int) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add where the stick edge of a `span`
    of slip passes tangential loads, which the stroke before has left.

    That stroke slipped the other way and had a smooth end: the rates of the loads did not jump, and
    one side of the contact stopped before the other. A load dT left at eta adds f (P - eta) dT, P
    being the normal load when the stick edge passes eta. The matrix is over (alpha_P, alpha_Q, e_P,
    e_Q), tilt and bulk strain per load. `n_panels` are those of this integral; `radius` is R of the
    parabola.

    # notation: N'' second rate of f P - s Q, a_s' rate of f alpha - s eps at that smooth end, alpha
    #           tilt, eps bulk strain, s direction of slip, M(eta) tangential force of the flat
    #           punches up to the load eta
    """
    memory_piece = span.sticking_piece
    if memory_piece is None or not is_at_coulomb_limit(
        memory_piece, -span.direction, span.friction
    ):
        return np.zeros((4, 4))
    smooth_end = _smooth_end_at_anchor(memory_piece, -span.direction, span.friction, radius)
    if smooth_end is None:
        return np.zeros((4, 4))
    # Loads eta of punches, and the tangential load left next to each over R a_s'^2/N'';
    # tilt_rate_form is R a_s'^2/N'' as a quadratic form of tilt and strain.
    eta, tangential_load_left = smooth_end.remaining_loads(n_panels)
    # P_c, which falls in slip
    stick_edge_load_at_end = span.end.normal_load - float(span.slip_zone_load(span.end.time))
    stick_edge_load_at_begin = span.begin.normal_load - float(span.slip_zone_load(span.begin.time))
    # Only the punches that the stick edge passes in this span.
    is_passed = (eta < stick_edge_load_at_begin) & (eta >= stick_edge_load_at_end)
    eta = eta[is_passed]
    normal_load_at_passage = _load_when_stick_edge_at(eta, span, memory_piece)
    integral_of_load_left = float(
        np.sum(tangential_load_left[is_passed] * (normal_load_at_passage - eta))
    )
    return np.asarray(span.friction * integral_of_load_left * smooth_end.tilt_rate_form)


def _load_when_stick_edge_at(eta: Array, span: Span, memory_piece: Piece) -> Array:
    """Normal load P when the stick edge passes the loads `eta` (n,) of a piece of the memory curve,
    in a span of slip, (n,) [force per thickness].

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. The
    stick edge is at eta when s Q - f P of the path equals s M(eta) - f eta, s the direction of
    slip. Both are counted from the `anchor`, the instant from which the piece is measured.
    """
    s_q_minus_f_p = slip_combination(span.direction, span.friction)
    change_to_begin = float(
        combination_change(memory_piece.anchor, span.segment, s_q_minus_f_p, span.begin.time)
    )
    change_to_eta = slip_combination_on_piece(memory_piece, span.direction, span.friction, eta)
    passing_time = span.segment.time_of(
        s_q_minus_f_p, change_to_eta - change_to_begin, span.begin.time, span.end.time
    )
    return span.segment.loads(passing_time)[0]


# ------------------------------------------------------------------------------- where it holds
def _one_sided_slip_coefficients(span: Span, radius: float, modulus: float) -> Iterator[Array]:
    """Criteria by which both sides of the contact slip alike in a span of time, or both stick: two
    ratios that tilt and strain must keep below 1.

    1. In slip, the distance of the centres of stick and contact over the width a - c of the slip
       zone.
    2. The slip rate at an edge of contact that tilt and strain cause over the one that the loads
       cause. In stick it is taken for slip in each direction.

    Each comes as coefficients (n, 4) of o = (alpha_P, alpha_Q, e_P, e_Q), tilt and bulk strain per
    load, at n instants. None is needed in stick if P does not grow. a and c are the half-widths of
    contact and stick, `radius` is R of the parabola, `modulus` E*.
    """
    # _GAUSS_POINTS: 24, of which half are taken.
    time, _ = _gauss_times(span, _GAUSS_POINTS // 2)
    normal_load = span.segment.loads(time)[0]
    normal_rate, _ = span.segment.rates(time)
    if not span.direction and np.all(normal_rate <= 0):
        return  # at rest, or unloaded along the memory curve itself

    # Hertz' law: a^2 = 4 P R/(pi E*).
    half_width = np.sqrt(4 * normal_load * radius / (np.pi * modulus))
    # sqrt(a^2 - c^2)/arccosh(a/c), which is a in stick, c = a
    slip_rate_length = half_width
    if span.sticking_piece is not None and span.direction:
        slip_zone_load = span.slip_zone_load(time)
        # c/a = sqrt(P_c/P) of a parabola, kept off 0 and 1.
        stick_ratio = np.sqrt(
            np.clip(
                1 - slip_zone_load / normal_load, _LEAST_STICK_RATIO**2, 1 - _EQUALITY_TOLERANCE
            )
        )
        slip_rate_length = half_width * np.sqrt(1 - stick_ratio**2) / np.arccosh(1 / stick_ratio)
        # First criterion: distance of the centres over a - c.
        stick_edge = _stick_edge_at(span, span.sticking_piece, time, slip_zone_load, radius)
        yield stick_edge.centre_distance(radius) / (half_width * (1 - stick_ratio))[:, None]
    # Second criterion.
    for direction in (span.direction,) if span.direction else (1, -1):
        yield _contact_edge_slip_coefficients(span, direction, time, slip_rate_length, modulus)


def _contact_edge_slip_coefficients(
    span: Span, direction: int, time: Array, slip_rate_length: Array, modulus: float
) -> Array:
    """Slip rate at an edge of contact by tilt and strain, divided by that by the loads, at times
    (n,) of a span: coefficients (n, 4) of (alpha_P, alpha_Q, e_P, e_Q).

        a_s' sqrt(a^2 - c^2) / ((A/pi) |N'| arccosh(a/c))

    with N = f P - s Q and a_s = f alpha - s eps. Where this is above 1, one side of the contact
    slips alone.

    s is the `direction` of slip, alpha the tilt, eps the bulk strain, ' is d/dt, A = 2/E*, E* the
    `modulus`. a and c are the half-widths of contact and stick. `slip_rate_length` (n,) is
    sqrt(a^2 - c^2)/arccosh(a/c), which is a in stick, c = a [length].
    """
    s_q_minus_f_p = slip_combination(direction, span.friction)
    rate_of_s_q_minus_f_p = np.abs(span.segment.rate_of(s_q_minus_f_p, time))  # |N'|
    length_over_load_rate = slip_rate_length / np.maximum(
        rate_of_s_q_minus_f_p, np.finfo(float).tiny
    )
    # a_s' as coefficients (n, 4).
    rate_of_a_s = _equivalent_tilt_coefficients(span.friction, direction, *span.segment.rates(time))
    return np.asarray(np.pi * modulus / 2 * length_over_load_rate[:, None] * rate_of_a_s)
