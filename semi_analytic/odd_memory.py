"""What tilt and bulk strain of finite bodies, which follow the loads, make of the dissipation: to
the second order, beside the memory curve of half-planes, without grids. For parabolas.

With alpha = alpha_P P + alpha_Q Q the tilt and eps = e_P P + e_Q Q the bulk strain, a parabola of
radius R touches about -alpha R. Stick and slip go as half-planes say; an odd memory goes beside
M(eta). An index m says when the memory at a load eta was last set: at the end of the stroke that
slipped there, or when the contact grew in stick to eta. With sigma = dM/d eta there, s the sense of
slip, ::

    N = f P - s Q,    a_s = f alpha - s eps,    mu = f - s sigma
    v = -R (a_s - a_s,m)/mu
    centre of contact  -alpha R,    centre of stick  -alpha_m R + v,    D their distance

W gains, in units of R times numbers squared, over all slip of a cycle

1. while both edges slip one way,  f (-N' D^2/(2R) - a_s' D (P - P_c)) dt;
2. where the front passes memory that grew in stick,
   -s f (P - P_c) (v^2 sigma'/(2R) + v (sigma alpha_m' - eps_m')) |dP_c|, ' by eta;
3. where it passes a kink of M, from mu_o, centre d_o to mu_i, d_i,
   f (P - P_c) (d_o - d_i)^2 mu_o mu_i/(2R (mu_o - mu_i));
4. for each smooth end of a stroke, at P_e, what `stroke_end` finds to be left, T: over P_c < eta <
   P_e the force R (a_s'^2/N'') T P_e/eta, which costs f times itself times (P_e - eta), and times
   (P - eta) once more when the front of the next stroke passes eta.

Each is a quadratic form of o = (alpha_P, alpha_Q, e_P, e_Q). Source: second order of the odd part
of Coulomb's problem, derived here; held to grids, to closed cases, and to fronts of an earlier
version.

Declined, with the reason: a cycle in which slip comes back to an earlier limit under other loads
and passes it (an inner loop that closes, or P that falls across a slip line of M), contact that
grows or shrinks along the limit of friction, gross sliding.

# notation: A = 2/E*, eta load in [0, P], M(eta) memory curve, P_c load at the front of slip, a
#           contact half-width, c stick half-width
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

ODD_NUMBERS = (
    "tilt_under_pressure",
    "tilt_under_shear",
    "strain_under_pressure",
    "strain_under_shear",
)
"""alpha_P, alpha_Q, e_P, e_Q among the fields of `BodyEffects`."""

# Points of Gauss on a span, and panels of what a smooth stroke end leaves: as many again, halved,
# for the error.
_POINTS = 24
_PANELS = 80
# A stroke ends smoothly where the level's rate is this share of its largest in the span.
_AT_REST = 1e-6
# Of the next order: see `OddWork.added`. Beyond the second, grids differ by up to several times W.
_NEXT_ORDER = 0.5
_MOST_ONE_SIDED = 0.8
# Segments of a path at most: each takes a millisecond.
_MOST_SEGMENTS = 1000
# Step of a derivative of rates, over the time of a segment.
_STEP = 1e-4
# Share of a load, or of f, within which two are one.
_SAME = 1e-9
# Below this c/a at the end of a stroke all but slides.
_LEAST_STICK = 1e-3


@dataclass(frozen=True, eq=False)
class OddWork:
    """What the odd numbers add to the work of a cycle: o . matrix o.

    Attributes
    ----------
    matrix
        of (alpha_P, alpha_Q, e_P, e_Q), each per load, (4, 4) symmetric [work / number squared]
    coarse
        the same with half as many points: the difference is the error
    one_sided
        for each span and sense rows (n, 4) at some instants: where |row . o| is above 1, tilt and
        strain are faster than what makes slip or stick, and one side of the contact alone slips
    declined
        why there is no matrix; empty where there is one
    """

    matrix: Array
    coarse: Array
    one_sided: tuple[Array, ...] = ()
    declined: str = ""

    def added(self, numbers: ArrayLike) -> Estimate:
        """Friction work that tilt and bulk strain add in a cycle, with its uncertainty, from the
        four numbers o = (alpha_P, alpha_Q, e_P, e_Q) of tilt and strain per load: o . matrix o.

        The uncertainty is that of the quadrature, and of the next order: half of the sum of all
        |terms| times the share by which one side slips more. Fitted to 500 random ellipses and
        polygons on grids: the true error was a third of that at most, but once 0.99.

        Raises
        ------
        Declined
            Where there is no matrix, or one side alone slips through most of a span, a time of slip
            in one direction.
        """
        if self.declined:
            raise Declined(self.declined)
        odd_numbers = np.asarray(numbers, dtype=float)
        one_sided_share = self.one_sidedness(odd_numbers)
        if one_sided_share > _MOST_ONE_SIDED:
            raise Declined("tilt and strain go so fast that one side of the contact slips alone")
        work = float(odd_numbers @ self.matrix @ odd_numbers)
        quadrature_error = abs(work - float(odd_numbers @ self.coarse @ odd_numbers))
        work_size = float(np.abs(odd_numbers) @ np.abs(self.matrix) @ np.abs(odd_numbers))
        return Estimate(work, quadrature_error + _NEXT_ORDER * one_sided_share * work_size)

    def one_sidedness(self, numbers: ArrayLike) -> float:
        """Largest over spans and senses of the median of |row . o|."""
        odd = np.asarray(numbers, dtype=float)
        shares = [float(np.median(np.abs(rows @ odd))) for rows in self.one_sided]
        return max(shares, default=0.0)


class Declined(Exception):
    """The second order does not hold for a history, or not for so large numbers."""


@dataclass(frozen=True, eq=False)
class OddAnswer:
    """What tilt and bulk strain of the bodies make of half-planes along a path.

    Attributes
    ----------
    history
        of half-planes
    radius
        R of the parabola
    numbers
        alpha_P, alpha_Q, e_P, e_Q
    works
        work that they add in each cycle up to the steady one, or in a path without cycle; with the
        uncertainty of `OddWork.added` and of the numbers
    """

    history: History
    radius: float
    numbers: Array
    works: tuple[Estimate, ...]

    def centres(self, time: Array) -> tuple[Array, Array]:
        """Centres of the contact and of the stick zone at instants (n,), (n,) each [length], to the
        first order in tilt and bulk strain.

        A symmetric contact would have both at 0. Each instant is taken on the span of stick or slip
        that holds it.
        """
        spans = self.history.spans
        ends_of_spans = np.array([span.end.time + span.delay for span in spans])
        start = spans[0].begin.time + spans[0].delay
        path_time, slack = time_in_followed_path(
            time, float(start), float(ends_of_spans[-1]), self.history.period
        )
        number_of_span = np.minimum(
            np.searchsorted(ends_of_spans, path_time - slack, side="left"), len(spans) - 1
        )
        contact_centres = np.zeros(len(time))
        stick_centres = np.zeros(len(time))
        for k in np.unique(number_of_span):
            span = spans[k]
            is_inside = number_of_span == k
            times_in_segment = np.clip(
                path_time[is_inside] - span.delay, span.begin.time, span.end.time
            )
            contact_rows, stick_rows = centres(span, self.radius, times_in_segment)
            contact_centres[is_inside] = contact_rows @ self.numbers
            stick_centres[is_inside] = stick_rows @ self.numbers
        return contact_centres, stick_centres


def odd_answer(scene: Scene, effects: BodyEffects) -> OddAnswer:
    """Friction work that tilt and bulk strain of finite bodies add in each cycle of a scene, and
    the shift of contact and stick zone.

    Both in the second order of these small numbers: half-planes are followed along the path; the
    work is a quadratic form of tilt and strain per load.

    Raises
    ------
    Declined
        For profiles other than a parabola, unlike materials, long paths; where the second order
        does not hold.
    """
    profile = scene.profile
    if not isinstance(profile, Hertz):
        raise Declined("the second order is known of a parabola")
    if effects.dundurs_beta:
        raise Declined("the materials are unlike, and tilt and strain count in the first order")
    path = scene.load.path()
    segments = len(path.initial_loading) + len(path.cycle)
    if segments > _MOST_SEGMENTS:
        raise Declined(f"the path has {segments} segments, more than {_MOST_SEGMENTS}")
    history = history_of(path, scene.friction.coefficient, max(scene.cycles, 2))
    modulus = composite_modulus(scene.material)
    estimates = [getattr(effects, name) for name in ODD_NUMBERS]
    odd_numbers = np.array([float(estimate.value) for estimate in estimates])
    uncertainties = np.array([float(estimate.uncertainty) for estimate in estimates])
    works_of_cycles = []
    for spans, span_before, next_span in _cycles(history):
        work_form = odd_work(spans, profile.radius, modulus, span_before, next_span)
        added_work = work_form.added(odd_numbers)
        error_of_numbers = 2 * float(np.abs(odd_numbers) @ np.abs(work_form.matrix) @ uncertainties)
        works_of_cycles.append(
            Estimate(added_work.value, added_work.uncertainty + error_of_numbers)
        )
    return OddAnswer(history, profile.radius, odd_numbers, tuple(works_of_cycles))


def _cycles(history: History) -> Iterator[tuple[tuple[Span, ...], Span | None, Span | None]]:
    """Each cycle of a friction history, or the whole path where it does not repeat: its spans of
    stick and slip, the span before them and the one after them, None where there is none.

    The steady cycle follows itself.
    """
    earlier_spans = history.loading
    for number, spans in enumerate(history.cycles):
        span_before = earlier_spans[-1] if earlier_spans else None
        next_span = spans[0] if history.repeats else None
        if history.repeats and number == history.steady_from:
            span_before = spans[-1]
        elif number + 1 < len(history.cycles):
            next_span = history.cycles[number + 1][0]
        yield spans, span_before, next_span
        earlier_spans = spans


def odd_work(
    spans: Sequence[Span],
    radius: float,
    modulus: float,
    span_before: Span | None,
    next_span: Span | None,
) -> OddWork:
    """Friction work of a cycle, or of a whole path, that is quadratic in tilt and bulk strain.

    They make tractions that are odd in x, so that work has no first order in them. With o = (tilt
    per P, tilt per Q, bulk strain per P, bulk strain per Q) the work is o . matrix o. The matrix
    (4, 4) is taken twice, with all points of the quadrature and with half of them. Where an odd
    number is so large that one side of the contact slips alone, no matrix holds: rows that show it
    are returned too, and NaN with the reason where there is no matrix at all.

    Parameters
    ----------
    spans
        parts of the cycle, or of the path, in full stick or with slip in one direction
    radius, modulus
        R of the parabola, E*
    span_before, next_span
        the spans on both sides; of a steady cycle its own last and first
    """
    unknown_matrix = np.full((4, 4), np.nan)
    strokes = _Strokes(tuple(spans), radius, span_before, next_span)
    try:
        strokes.require_no_limit_in_stick()
        fine_matrix = strokes.matrix(_POINTS, _PANELS)
        coarse_matrix = strokes.matrix(_POINTS // 2, _PANELS // 2)
    except Declined as reason:
        return OddWork(unknown_matrix, unknown_matrix, declined=str(reason))
    one_sided_rows = [rows for span in spans for rows in _one_sided(span, radius, modulus)]
    return OddWork(fine_matrix, coarse=coarse_matrix, one_sided=tuple(one_sided_rows))


def centres(span: Span, radius: float, time: Array) -> tuple[Array, Array]:
    """Rows that give the centres of contact and of the stick zone of a tilted parabola at times
    (n,) of a span of stick or slip, (n, 4) each: row . (alpha_P, alpha_Q, e_P, e_Q) is a length.

    These are the tilt and the bulk strain per normal and per tangential load; first order. The
    centre of stick is that of contact where all of it sticks, NaN where none does.
    """
    normal_load, tangential_load = span.segment.loads(time)
    contact_rows = -radius * _tilt(normal_load, tangential_load)
    if not span.direction:
        return contact_rows, contact_rows
    if span.sticking_piece is None:
        return contact_rows, np.full(contact_rows.shape, np.nan)
    stick_edge = _stick_edge_at(span, span.sticking_piece, time, span.slipped(time), radius)
    return contact_rows, contact_rows + stick_edge.distance(radius)


@dataclass(frozen=True, eq=False)
class _Strokes:
    """The spans of slip and stick of a cycle, on a parabola of this `radius` [length]; `before` and
    `following` are the spans on both sides of the cycle, None where there is none.
    """

    spans: tuple[Span, ...]
    radius: float
    before: Span | None
    following: Span | None

    def matrix(self, points: int, panels: int) -> Array:
        """Symmetric matrix (4, 4) of the friction work that tilt and bulk strain add, over o =
        (alpha_P, alpha_Q, e_P, e_Q), their values per normal and per tangential load: work = o .
        matrix o.

        The memory curve M(eta) is the tangential force of the flat punches up to the load eta. The
        matrix is the sum over the spans of slip, of the kinks of the memory curve that they pass,
        and of the smooth ends of strokes. `points` are quadrature nodes a span, `panels` those of a
        stroke's end.
        """
        work_matrix = np.zeros((4, 4))
        neighbours = (self.before, *self.spans, self.following)
        for span_before, span, next_span in zip(
            neighbours[:-2], self.spans, neighbours[2:], strict=True
        ):
            if not span.direction:
                continue
            if span_before is not None:
                _require_no_return(span_before, span, self.radius)
                work_matrix += _of_kink(span_before, span, self.radius)
            work_matrix += _of_span(span, self.radius, points)
            work_matrix += _of_passed_end(span, self.radius, panels)
            if next_span is None or next_span.direction != span.direction:
                work_matrix += _of_stroke_end(span, self.radius, panels)
        return work_matrix

    def require_no_limit_in_stick(self) -> None:
        """Declined where contact grows or shrinks along the limit of friction: one side slips."""
        for span in self.spans:
            piece = span.sticking_piece
            if span.direction or piece is None or span.begin.normal == span.end.normal:
                continue
            if _is_slipped(piece, span.friction):
                raise Declined("P and Q go along the limit of friction, where one side slips")


# ------------------------------------------------------------------------- numbers as row vectors
def _tilt(normal_load: ArrayLike, tangential_load: ArrayLike) -> Array:
    """Alpha by the numbers at loads (n,): (n, 4)."""
    zero = np.zeros(np.shape(normal_load))
    return np.stack([np.asarray(normal_load), np.asarray(tangential_load), zero, zero], axis=-1)


def _strain(normal_load: ArrayLike, tangential_load: ArrayLike) -> Array:
    """Eps by the numbers at loads (n,): (n, 4)."""
    zero = np.zeros(np.shape(normal_load))
    return np.stack([zero, zero, np.asarray(normal_load), np.asarray(tangential_load)], axis=-1)


def _drive(
    friction: float, sense: int, normal_load: ArrayLike, tangential_load: ArrayLike
) -> Array:
    """a_s = f alpha - s eps by the numbers at loads (n,): (n, 4)."""
    return friction * _tilt(normal_load, tangential_load) - sense * _strain(
        normal_load, tangential_load
    )


def _products(weights: Array, left_factor: Array, right_factor: Array) -> Array:
    """Sum of weights (n,) times the symmetric products of rows (n, 4): (4, 4)."""
    form = np.einsum("n,ni,nj->ij", weights, left_factor, right_factor)
    return np.asarray((form + form.T) / 2)


# ------------------------------------------------------------------------------ a front in a span
@dataclass(frozen=True, eq=False)
class _StickEdge:
    """The stick edge in the uppermost piece of the memory curve, at some instants.

    Attributes
    ----------
    slipped
        P - P_c, (n,)
    steepness
        mu, (n,)
    since_set
        P and Q at the instant less P and Q when the memory at the edge was set, (n,) each
    shift
        v by the numbers, (n, 4)
    """

    load: Array
    slipped: Array
    steepness: Array
    since_set: tuple[Array, Array]
    shift: Array

    def distance(self, radius: float) -> Array:
        """D, from the centre of contact to that of stick, by the numbers: (n, 4)."""
        return np.asarray(radius * _tilt(*self.since_set) + self.shift)


def _stick_edge_at(
    span: Span, piece: Piece, time: Array, slipped: Array, radius: float
) -> _StickEdge:
    """The stick edge at times (n,) of a span of slip, where its load P_c = P - `slipped` (n,) lies
    on a `piece` of the memory curve; with the change of P and Q since the memory there was set.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. Tilt and
    strain shift the centre of stick by v = -R (a_s - a_s,m)/mu, a_s = f alpha - s eps. mu = f - s
    M' is the steepness, s the direction of slip, m the instant at which the memory was set.
    """
    load = span.segment.loads(time)[0]
    memory_slope = piece.slope_at(load - slipped)
    steepness = span.friction - span.direction * memory_slope
    if _is_slipped(piece, span.friction):
        since_set = (
            combination_change(piece.anchor, span.segment, NORMAL_LOAD, time),
            combination_change(piece.anchor, span.segment, TANGENTIAL_LOAD, time),
        )
    else:
        # s M - f eta is the same at the front now and at the edge: Q less M(P_c) is s f (P - P_c)
        since_set = (slipped, span.direction * span.friction * slipped)
    shift = -radius * _drive(span.friction, span.direction, *since_set) / steepness[:, None]
    return _StickEdge(load, slipped, steepness, since_set, shift)


def _is_slipped(piece: Piece, friction: float) -> bool:
    """Whether the memory was set by slip: the limit M' = f or -f up to the end of a stroke."""
    return is_at_coulomb_limit(piece, 1, friction) or is_at_coulomb_limit(piece, -1, friction)


def _set_loads(piece: Piece, friction: float, eta: Array) -> tuple[Array, Array]:
    """P and Q when the memory at loads (n,) on a piece was set, (n,) each."""
    if _is_slipped(piece, friction):
        ones = np.ones(np.shape(eta))
        return piece.anchor.normal * ones, piece.anchor.tangential * ones
    return eta, force_on_piece(piece, eta)


def _slope_rate(piece: Piece, eta: Array) -> Array:
    """Change of the slope M' = dQ/dP of a `piece` of the memory curve with the load, at loads eta
    (n,) [1/force per thickness].

    The change is constant on a straight or parabolic piece; on a curved one it is found by
    differences of the rates of the loads. The memory curve M(eta) is the tangential force of the
    flat punches up to the load eta.
    """
    if piece.arc is None:
        return np.full(np.shape(eta), 2 * piece.bend)
    segment = piece.anchor.segment
    time = time_of_load_on_arc(piece, eta)
    time_step = _STEP * (piece.arc[1] - piece.arc[0])
    slopes = []
    for shifted_time in (time - time_step, time + time_step):
        normal_rate, tangential_rate = segment.rates(shifted_time)
        slopes.append(tangential_rate / normal_rate)
    return np.asarray((slopes[1] - slopes[0]) / (2 * time_step * segment.rates(time)[0]))


# ---------------------------------------------------------------------------------- terms of work
def _instants(span: Span, points: int) -> tuple[Array, Array]:
    """Gauss' times in a span, and their weights in time, (points,) each."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    half = (span.end.time - span.begin.time) / 2
    return span.begin.time + half * (1 + nodes), half * weights


def _of_span(span: Span, radius: float, points: int) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add in a span of slip in one
    direction, over (alpha_P, alpha_Q, e_P, e_Q): both edges slip alike, through memory that grew in
    stick.

        f (-N' D^2/(2R) - a_s' D (P - P_c)) dt,    D from the centre of contact to that of stick,
        N = f P - s Q,    a_s = f alpha - s eps,    s the direction of slip

    and the shift of the memory that grew in stick. By Gauss' rule of `points` nodes in time.
    """
    piece = span.sticking_piece
    if piece is None:
        raise Declined("the contact slides as a whole")
    time, weights = _instants(span, points)
    slipped = span.slipped(time)
    stick_edge = _stick_edge_at(span, piece, time, slipped, radius)
    fall_rate = np.asarray(
        span.segment.rate_of(slip_combination(span.direction, span.friction), time)
    )  # -N'
    drive_rate = _drive(span.friction, span.direction, *span.segment.rates(time))
    distance = stick_edge.distance(radius)
    friction_weights = span.friction * weights
    work_matrix = _products(friction_weights * fall_rate / (2 * radius), distance, distance)
    work_matrix = work_matrix - _products(friction_weights * slipped, drive_rate, distance)
    if _is_slipped(piece, span.friction):
        return work_matrix
    eta = stick_edge.load - slipped
    memory_slope = piece.slope_at(eta)
    ones = np.ones(np.shape(eta))
    rotation = memory_slope[:, None] * _tilt(ones, memory_slope) - _strain(ones, memory_slope)
    passing_rate = span.direction * friction_weights * slipped * fall_rate / stick_edge.steepness
    bend_term = _products(
        passing_rate * _slope_rate(piece, eta) / (2 * radius), stick_edge.shift, stick_edge.shift
    )
    return work_matrix - bend_term - _products(passing_rate, stick_edge.shift, rotation)


def _of_kink(span_before: Span, span: Span, radius: float) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add where the stick edge goes across
    a kink of the memory curve, over (alpha_P, alpha_Q, e_P, e_Q).

        f (P - P_c) (d_o - d_i)^2 mu_o mu_i/(2R (mu_o - mu_i))

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. d are
    the centres and mu the steepness f - s M' on the outer and on the inner piece of the curve,
    those of `span_before` and of `span`, times of slip. Zero where both are on one piece. `radius`
    is R of the parabola [length].
    """
    outer_piece = span_before.sticking_piece
    inner_piece = span.sticking_piece
    zero_matrix = np.zeros((4, 4))
    if span_before.direction != span.direction or outer_piece is None or inner_piece is None:
        return zero_matrix
    tolerance = _SAME * outer_piece.top
    if inner_piece.top > outer_piece.bottom + tolerance:
        return zero_matrix  # the same piece goes on
    if inner_piece.top - inner_piece.bottom <= tolerance:
        return zero_matrix  # the stick edge stays at the upper end of what is at the limit
    # Of a kink that stands for several, those between are at the limit: only both ends count.
    time = np.array([span.begin.time])
    slipped = span.begin.normal - np.array([outer_piece.bottom])
    eta = np.array([outer_piece.bottom])
    centres = []
    steepness = []
    for piece in (outer_piece, inner_piece):
        stick_edge = _stick_edge_at(span, piece, time, slipped, radius)
        touching_centre = -radius * _tilt(*_set_loads(piece, span.friction, eta))
        centres.append(touching_centre + stick_edge.shift)
        steepness.append(float(stick_edge.steepness[0]))
    product_of_steepness = steepness[0] * steepness[1]
    if abs(steepness[0] - steepness[1]) <= _SAME * span.friction or product_of_steepness <= 0:
        return zero_matrix
    centre_jump = centres[0] - centres[1]
    weight = (
        span.friction
        * slipped
        * product_of_steepness
        / (2 * radius * (steepness[0] - steepness[1]))
    )
    return _products(weight, centre_jump, centre_jump)


def _require_no_return(span_before: Span, span: Span, radius: float) -> None:
    """Refuse a path on which slip comes back to what an earlier stroke in its direction left at the
    Coulomb limit, under other loads than then: Declined, since tilt and strain are others too.

    `span_before` ends where the `span` of slip begins; `radius` is that of the parabola [length].
    """
    friction = span.friction
    begin = span.begin
    top_of_piece = span.sticking_piece.top if span.sticking_piece is not None else 0.0
    for piece in pieces(span_before.curve(span_before.end.time)):
        load_tolerance = _SAME * max(piece.anchor.normal, begin.normal)
        if piece.bottom < top_of_piece - load_tolerance:
            break
        if piece.top - piece.bottom <= load_tolerance or not is_at_coulomb_limit(
            piece, span.direction, friction
        ):
            continue
        change_of_loads = (
            begin.normal - piece.anchor.normal,
            begin.tangential - piece.anchor.tangential,
        )
        end_of_stroke = _end_of_piece(piece, span.direction, friction, radius)
        if (
            abs(change_of_loads[0]) > load_tolerance
            or abs(change_of_loads[1]) > friction * load_tolerance
        ):
            raise Declined("slip comes back to an earlier limit under other loads")
        if end_of_stroke is not None and np.any(end_of_stroke.form):
            raise Declined("slip goes on after a smooth end of its stroke")


@dataclass(frozen=True, eq=False)
class _SmoothEnd:
    """The smooth end of a stroke.

    Attributes
    ----------
    load, front
        P and P_c there
    form
        R a_s'^2/N'' by the numbers, (4, 4)
    """

    load: float
    front: float
    form: Array

    def left(self, panels: int) -> tuple[Array, Array]:
        """Loads eta (n,) and what is left there, T P_e/eta d eta over R a_s'^2/N'', (n,)."""
        ratio = float(np.sqrt(self.front / self.load))
        if ratio < _LEAST_STICK:
            raise Declined("all but the middle of the contact slides")
        left = loads_left_at_stroke_end(ratio, panels)
        eta = self.load * left.half_width**2
        # d eta/eta is 2 dc'/c'
        return eta, 2 * self.load * left.force * left.width / left.half_width


def _smooth_end(span: Span, time: float, edge_load: float, radius: float) -> _SmoothEnd | None:
    """The smooth end of a stroke of slip at a `time` in the load segment of a span of slip, with
    P_c = `edge_load` there; None where the stroke ends at a corner of the path.

    At a smooth end the rate of s Q - f P, which grows in slip, vanishes; s is the direction of
    slip. `radius` is R of the parabola [length].
    """
    segment = span.segment
    combination = slip_combination(span.direction, span.friction)
    middle_time = (span.begin.time + span.end.time) / 2
    rates = [
        abs(float(segment.rate_of(combination, rate_time)))
        for rate_time in (span.begin.time, middle_time, time)
    ]
    load = float(segment.loads(time)[0])
    if rates[2] > _AT_REST * max(rates) or edge_load >= load * (1 - _SAME):
        return None
    time_step = _STEP * (segment.end - segment.start)
    rate_after = float(segment.rate_of(combination, time + time_step))
    rate_before = float(segment.rate_of(combination, time - time_step))
    level_bend = (rate_before - rate_after) / (2 * time_step)  # N''
    if level_bend <= 0:
        return None
    drive_rate = _drive(span.friction, span.direction, *segment.rates(time))
    return _SmoothEnd(load, edge_load, radius / level_bend * np.outer(drive_rate, drive_rate))


def _end_of_piece(
    piece: Piece, direction: int, friction: float, radius: float
) -> _SmoothEnd | None:
    """The smooth end of the stroke that left a piece at the limit; None where it was a corner."""
    anchor = piece.anchor
    start = instant(anchor.segment, anchor.segment.start)
    stroke = Span(start, anchor, 0.0, direction, None, friction)
    return _smooth_end(stroke, anchor.time, piece.bottom, radius)


def _of_stroke_end(span: Span, radius: float, panels: int) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add at the smooth end of the stroke
    that ends with a `span` of slip, over (alpha_P, alpha_Q, e_P, e_Q); zero at a corner of the
    path.

    There the two sides of the contact come to rest one after the other, which leaves a force at
    loads eta; it costs f times itself times (P - eta). `panels` is the number of quadrature panels.
    """
    edge_load = span.end.normal - float(span.slipped(span.end.time))
    smooth_end = _smooth_end(span, span.end.time, edge_load, radius)
    if smooth_end is None:
        return np.zeros((4, 4))
    eta, force_left_at_eta = smooth_end.left(panels)
    return np.asarray(
        span.friction * float(np.sum(force_left_at_eta * (smooth_end.load - eta))) * smooth_end.form
    )


def _of_passed_end(span: Span, radius: float, panels: int) -> Array:
    """Matrix (4, 4) of the friction work that tilt and strain add where the stick edge passes, in a
    span of slip, what the smooth end of an earlier stroke in the other direction left.

    Over (alpha_P, alpha_Q, e_P, e_Q). The force left at the load eta costs f times itself times (P
    - eta) when the stick edge passes eta. `radius` is that of the parabola, `panels` the number of
    quadrature panels.
    """
    piece = span.sticking_piece
    if piece is None or not is_at_coulomb_limit(piece, -span.direction, span.friction):
        return np.zeros((4, 4))
    smooth_end = _end_of_piece(piece, -span.direction, span.friction, radius)
    if smooth_end is None:
        return np.zeros((4, 4))
    anchor = piece.anchor
    eta, force_left_at_eta = smooth_end.left(panels)
    edge_load_at_end = span.end.normal - float(span.slipped(span.end.time))
    edge_load_at_begin = span.begin.normal - float(span.slipped(span.begin.time))
    is_passed = (eta < edge_load_at_begin) & (eta >= edge_load_at_end)
    eta = eta[is_passed]
    slip_level = slip_combination(span.direction, span.friction)
    level_at_begin = float(combination_change(anchor, span.segment, slip_level, span.begin.time))
    level_rise = (
        slip_combination_on_piece(piece, span.direction, span.friction, eta) - level_at_begin
    )
    time = span.segment.time_of(slip_level, level_rise, span.begin.time, span.end.time)
    load = span.segment.loads(time)[0]
    return np.asarray(
        span.friction * float(np.sum(force_left_at_eta[is_passed] * (load - eta))) * smooth_end.form
    )


# ------------------------------------------------------------------------------- where it holds
def _one_sided(span: Span, radius: float, modulus: float) -> Iterator[Array]:
    """Ratios that show whether both sides of the contact slip alike, or stick, in a span: rows (n,
    4); row . (alpha_P, alpha_Q, e_P, e_Q) must stay below 1.

    A span is a time in full stick or with slip in one direction. Rates: tilt and strain against
    what makes slip. Of N = f P - s Q alone the edges would slip by (A/pi) N' arccosh(a/c), of a_s =
    f alpha - s eps alone by a_s' sqrt(a^2 - c^2). In stick a stands in place of both functions.
    Places: the distance of the centres of contact and stick over the width of the slip zone.
    `radius` is that of the parabola, `modulus` E*.
    """
    time, _ = _instants(span, _POINTS // 2)
    load = span.segment.loads(time)[0]
    rates = span.segment.rates(time)
    if not span.direction and np.all(rates[0] <= 0):
        return  # at rest, or unloaded along the memory itself
    half_width = np.sqrt(4 * load * radius / (np.pi * modulus))
    senses = (span.direction,) if span.direction else (1, -1)
    edge_function = half_width
    if span.sticking_piece is not None and span.direction:
        slipped = span.slipped(time)
        width_ratio = np.sqrt(np.clip(1 - slipped / load, _LEAST_STICK**2, 1 - _SAME))
        edge_function = half_width * np.sqrt(1 - width_ratio**2) / np.arccosh(1 / width_ratio)
        centre_distance = _stick_edge_at(span, span.sticking_piece, time, slipped, radius).distance(
            radius
        )
        yield centre_distance / (half_width * (1 - width_ratio))[:, None]
    for sense in senses:
        level_rate = np.abs(span.segment.rate_of(slip_combination(sense, span.friction), time))
        ratio_to_slip = edge_function / np.maximum(level_rate, np.finfo(float).tiny)
        drive_rate = _drive(span.friction, sense, *rates)
        yield np.pi * modulus / 2 * ratio_to_slip[:, None] * drive_rate
