"""Curves through noisy measured rows: parabola, flat with rounded edges, even polynomial, smoothing
spline; all convex. A row is one measured point: x along the face, and h, the gap there.

# notation: x0 middle: the axis of symmetry of the profile, s = |x - x0|, L the largest s,
#           kappa = h'' >= 0, b half-length of a flat, sigma noise of h,
#           alpha tilt: slope at which the trace lay in the instrument

Each has a curvature that is a sum of basis curvatures kappa_j with weights w_j that are not
negative, so that the profile is convex and the contact can't split:

    h(x) = h0 + alpha (x - x0) + sum over j of w_j B_j(s)
    w_j >= 0,   B_j'' = kappa_j,   B_j(0) = B_j'(0) = 0

    parabola     kappa = 1
    flat         0 up to s = b, then 1
    polynomial   1, u, u (u - c)^2 and (u - c)^2 with u = (s/L)^2: their sums are the polynomials
                 without negative values at u >= 0
    spline       hat functions on evenly spaced knots; the squares of the steps of w are added with
                 a weight, which is that of the least expected error by Mallows (1973) from the
                 noise, or by generalised cross-validation without it

The w, h0 and alpha are found by least squares without negative w (Lawson and Hanson 1974) for given
x0 and b; these two by steps of Gauss and Newton on what is left of the rows (variable projection,
Golub and Pereyra 1973).

The tilt is no part of the profile. A parabola whose middle is fitted has none: there a tilt only
moves the middle. Rows of one side are taken as level. A trace that falls from end to end, as it lay
in the instrument, is levelled first by the straight line of least squares. Rows that are almost a
parabola hardly show a tilt, so the square of alpha is added with a weight: as if tilts had a
standard deviation of a tenth of the rise over the length. Where the rows show the tilt the weight
changes nothing.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from scenes.array_types import Array
from scenes.errors import NotFoundError, RowError
from scenes.spikes import LARGEST_FRACTION_OF_SPIKES, LEAST_RESIDUAL_OF_SPIKE, rows_that_stand_out

# Points that a fit needs: it has up to six parameters, and residuals have to be left for the noise.
_FEWEST_ROWS = 8
_MOST_ROWS = 20_000
# Least distance of the points from a known middle, over their largest one, up to which points on
# one side are enough: they need not begin exactly at x = 0.
_LARGEST_DISTANCE_SHARE_AT_MIDDLE = 0.1
# Points at x >= 0 are one half of a profile where the mean height of the first of so many parts is
# above the lowest by no more than this fraction of the range of these means.
_N_PARTS_OF_TRACE = 8
_LARGEST_RISE_SHARE_AT_MIDDLE = 0.05
# Range of the fitted profile, over that of the heights, below which it is round-off.
_LEAST_HEIGHT_RANGE_SHARE = 1e-9
# Repeats of a fit whose points depend on it: those within the extent, or without spikes.
_MOST_REPEATS_OF_FIT = 5
# Distance of the lowest place of a parabola from mid-length, over the half-length of the trace,
# from which on the trace counts as tilted.
_LARGEST_OFFSET_OF_LEVEL_TRACE = 0.3
# Standard deviation of residuals, over the largest residual, below which it is round-off.
_ROUND_OFF_SHARE_OF_RESIDUAL = 1e-9
# Number of different heights over that of points, below which heights are steps of the last digit.
_LEAST_FRACTION_OF_HEIGHTS = 0.7
# Double roots c of the curvature polynomials (u - c)^2, u = (s/L)^2.
_DOUBLE_ROOTS_OF_CURVATURE = np.concatenate(
    [np.linspace(0.0, 1.0, 21), np.geomspace(1.1, 10.0, 12)]
)
# Knots of the spline, from its middle on, and points of the table that stands for it in the scene.
_N_KNOTS = 31
_N_SPLINE_ROWS = 61
# Smoothing weights that are tried where none is known.
_TRIAL_WEIGHTS = np.logspace(-9, 3, 19)
# Half-lengths of the flat, over L, of which the best begins the search; the longest, which is the
# farthest fitted middle, too.
_TRIAL_HALF_LENGTHS = np.linspace(0.02, 0.94, 24)
_LONGEST_HALF_LENGTH = 0.98
# Middles, over L from the lowest place of a parabola, which are tried together with the
# half-lengths where a tilt has moved that place.
_TRIAL_MIDDLES = np.linspace(-0.45, 0.45, 7)
# Median of the square of a standard normal deviate.
_MEDIAN_OF_SQUARED_DEVIATE = 0.4549
# Standard deviation of the tilts that are expected, over the range of heights over the length.
_DEVIATION_OF_EXPECTED_TILTS = 0.1


@dataclass(frozen=True)
class FitRequest:
    """What is fitted, and what is known before.

    Attributes
    ----------
    kind
        "hertz", "flat_rounded", "even_polynomial" or "smoothing_spline"
    noise
        standard deviation of h; None: that of the residuals
    centre
        x of the middle, the axis of symmetry; None: fitted
    extent
        rows farther from the middle are left out; None: all count
    tilt
        slope of the trace; None: fitted where the rows can show it
    smoothing_weight
        factor on the squared differences of neighbouring spline weights; None: that of the least
        expected error
    first_guess
        middle and half-length of the flat at which the search begins; None: the best of many
    """

    kind: str
    noise: float | None = None
    centre: float | None = None
    extent: float | None = None
    tilt: float | None = None
    smoothing_weight: float | None = None
    first_guess: tuple[float, float] | None = None


def fitted_keys(x: Array, h: Array, request: FitRequest) -> dict[str, Any]:
    """Fit a convex profile to measured points by least squares, spikes left out: its keys for a
    scene file, with the record of the fit under `fitted`.

    A spike is a single point far from its neighbours and from the fit, such as dust. The first
    candidates are far from their neighbours; points far from the fit join them, and the fit is
    repeated. Candidates near the last fit, as at an edge of a flat, are taken back.

    Parameters
    ----------
    x, h
        (n,) places, ascending, and heights [length]; h grows away from the contact
    request
        `kind` of profile ("hertz", "flat_rounded", "even_polynomial", "smoothing_spline"), and what
        the user states: noise, middle, extent, tilt

    Raises
    ------
    RowError
        For too few or too many points, x that descends, points that curve down, or points on one
        side of the middle alone. One side is enough for a middle that is known, if the nearest
        point is within a tenth of the largest distance from it.
    """
    # Indices of points that may be spikes: first those far from their neighbours. A row is a point.
    candidate_rows = _spikes_of(x, h)
    all_rows = np.arange(len(x))
    # `keys` of a fit: the profile's keys; `height_at`: the fitted heights at any places.
    profile_fit = _fit_of_rows(np.delete(x, candidate_rows), np.delete(h, candidate_rows), request)

    # Points far from the fit join the candidates, in a few repeats.
    # _MOST_REPEATS_OF_FIT: 5 repeats
    for _ in range(_MOST_REPEATS_OF_FIT):
        rows_in_fit = np.delete(all_rows, candidate_rows)
        residuals = h[rows_in_fit] - profile_fit.height_at(x[rows_in_fit])
        further_candidates = rows_in_fit[_rows_far_from_fit(residuals)]
        n_candidates = len(candidate_rows) + len(further_candidates)
        # More than 5 % of the points are no spikes.
        if not len(further_candidates) or n_candidates > LARGEST_FRACTION_OF_SPIKES * len(x):
            break
        candidate_rows = np.sort(np.append(candidate_rows, further_candidates))
        profile_fit = _fit_of_rows(
            np.delete(x, candidate_rows), np.delete(h, candidate_rows), request
        )

    # Spikes are the candidates that are far from the last fit too.
    # A corner of the profile stands out from its neighbours, but not from the fit: it stays.
    distances_from_fit = np.abs(h[candidate_rows] - profile_fit.height_at(x[candidate_rows]))
    # LEAST_RESIDUAL_OF_SPIKE: 5 standard deviations of the noise
    spike_rows = candidate_rows[
        distances_from_fit > LEAST_RESIDUAL_OF_SPIKE * profile_fit.keys["fitted"]["noise"]
    ]
    if len(spike_rows) < len(candidate_rows):
        profile_fit = _fit_of_rows(np.delete(x, spike_rows), np.delete(h, spike_rows), request)
    if len(spike_rows):
        profile_fit.keys["fitted"]["spikes"] = tuple((spike_rows + 1).tolist())
    return profile_fit.keys


def _rows_far_from_fit(residuals: Array) -> NDArray[np.int64]:
    """Indices (m,) of residuals that are spikes, not noise: more than 5 standard deviations in
    size, and more than twice the size of both neighbours.

    The standard deviation comes from the median, which spikes do not move; residuals that are
    round-off of an exact fit have no spikes. `residuals` (n,) are measured minus fitted heights.
    """
    absolute_residuals = np.abs(residuals)
    # _MEDIAN_OF_SQUARED_DEVIATE: 0.4549, that of a standard normal number
    noise_deviation = float(np.median(absolute_residuals)) / math.sqrt(_MEDIAN_OF_SQUARED_DEVIATE)
    # _ROUND_OFF_SHARE_OF_RESIDUAL: 1e-9 of the largest residual
    if not noise_deviation > _ROUND_OFF_SHARE_OF_RESIDUAL * float(np.max(absolute_residuals)):
        return np.array([], dtype=np.int64)
    largest_neighbours = np.maximum(
        np.append(absolute_residuals[1:], 0.0), np.append(0.0, absolute_residuals[:-1])
    )
    # LEAST_RESIDUAL_OF_SPIKE: 5 standard deviations of the noise
    return np.flatnonzero(
        (absolute_residuals > LEAST_RESIDUAL_OF_SPIKE * noise_deviation)
        & (absolute_residuals > 2 * largest_neighbours)
    )


def _spikes_of(x: Array, h: Array) -> NDArray[np.int64]:
    """Indices (m,) of measured points x, h (n,) that stand out from their neighbours; none where x
    is not in order, and of fewer than 8 points or more than 20,000, which no fit takes.

    At most 5 % of the points are spikes: of fewer than 20 points none is.
    """
    # _FEWEST_ROWS, _MOST_ROWS: 8 and 20,000 points
    if not _FEWEST_ROWS <= len(x) <= _MOST_ROWS or np.any(np.diff(x) < 0):
        return np.array([], dtype=np.int64)
    # Standard deviation of the noise of h, by differences of neighbouring points.
    noise_deviation = max(math.sqrt(_noise_variance(x, h)), 1e-12 * float(np.ptp(h)))
    distinct_heights = np.unique(h)
    # _LEAST_FRACTION_OF_HEIGHTS: 0.7; fewer different heights are steps of the last digit, below
    # which noise hides.
    if 1 < len(distinct_heights) < _LEAST_FRACTION_OF_HEIGHTS * len(h):
        noise_deviation = max(noise_deviation, float(np.min(np.diff(distinct_heights))))
    return (
        rows_that_stand_out(x, h, noise_deviation)
        if noise_deviation > 0
        else np.array([], dtype=np.int64)
    )


class _Trace(NamedTuple):
    """Measured points made ready for a fit.

    Attributes
    ----------
    levelled_heights
        (n,) h minus the straight line of slope `tilt` [length]
    tilt
        slope that was removed
    known_middle
        x of the axis of symmetry where it is stated, or 0 where the points are one half of the
        profile; None: it is fitted
    is_one_sided
        whether all points lie on one side of the middle
    tilt_is_fitted
        whether a remaining tilt is fitted together with the profile
    first_middle
        x at which the search for the middle begins
    """

    levelled_heights: Array
    tilt: float
    known_middle: float | None
    is_one_sided: bool
    tilt_is_fitted: bool
    first_middle: float


def _levelled_trace(x: Array, h: Array, request: FitRequest) -> _Trace:
    """Prepare measured points x, h (n,) for a fit: level a trace that is tilted as a whole, and
    decide whether its middle (axis of symmetry) and a remaining tilt are fitted.

    A stated tilt is removed as it is. No tilt is fitted where all points lie on one side of the
    middle: they do not show one. Nor is one fitted to a parabola whose middle is fitted: a tilt
    only moves it. `_Trace` lists what is returned.

    Parameters
    ----------
    x, h
        (n,) places, ascending, and heights [length]
    request
        what is fitted, `kind`, and what is stated: `tilt` (slope of the trace), `centre` (x of the
        middle), and `first_guess` (middle and half-length of the flat); None where it is not stated
    """
    removed_tilt = request.tilt or 0.0
    levelled_heights = h - removed_tilt * (x - x[0])
    known_middle = request.centre
    may_be_tilted = request.tilt is None and known_middle is None and request.first_guess is None
    if may_be_tilted and _is_tilted_as_a_whole(x, h, request.kind):
        removed_tilt = float(np.polyfit(x - x[0], h, 1)[0])
        levelled_heights = h - removed_tilt * (x - x[0])

    # The middle: 0 for points that are the right half of a profile.
    if known_middle is None and _is_half_a_profile(x, levelled_heights):
        known_middle = 0.0

    # Whether a tilt is fitted together with the profile.
    is_one_sided = known_middle is not None and x[0] >= known_middle
    is_parabola_of_any_middle = request.kind == "hertz" and known_middle is None
    tilt_is_fitted = request.tilt is None and not is_one_sided and not is_parabola_of_any_middle

    # Where the search for the middle begins: the lowest place of the parabola through the points.
    first_middle = _lowest_place(x, levelled_heights) if known_middle is None else known_middle
    if request.first_guess is not None and known_middle is None:
        first_middle, _ = request.first_guess  # middle and half-length of the flat
    elif tilt_is_fitted and known_middle is None and not x[0] < first_middle < x[-1]:
        # The tilt is so large that the parabola is lowest beyond the points.
        first_middle = float(x[0] + x[-1]) / 2
    return _Trace(
        levelled_heights, removed_tilt, known_middle, is_one_sided, tilt_is_fitted, first_middle
    )


def _check_rows_of_fit(
    x: Array, h: Array, middle: float, middle_is_known: bool, last_row: int
) -> None:
    """Refuse measured points x, h (n,) to which no profile can be fitted: too few, all of one
    height, or all on one side of a middle that is not known.

    Parameters
    ----------
    middle
        x of the axis of symmetry about which the profile is fitted
    middle_is_known
        whether the middle is stated, not fitted: points on one side of it are then enough, if the
        nearest is within a tenth of the largest distance from it
    last_row
        index of the last measured point, for the message; a row is a point

    Raises
    ------
    RowError
        With the row, and what to do.
    """
    n_places = len(np.unique(x))
    # _FEWEST_ROWS: 8 places
    if n_places < _FEWEST_ROWS:
        raise RowError(
            last_row,
            f"{n_places} rows within the extent are too few for a fit: at least {_FEWEST_ROWS} are"
            " needed",
        )
    distances = np.abs(x - middle)
    # _LARGEST_DISTANCE_SHARE_AT_MIDDLE: 0.1 of the largest distance from the middle
    largest_distance_of_nearest = _LARGEST_DISTANCE_SHARE_AT_MIDDLE * float(np.max(distances))
    begins_near_middle = np.min(distances) <= largest_distance_of_nearest
    if not x[0] <= middle < x[-1] and not (middle_is_known and begins_near_middle):
        fault = (
            f"the middle, x = {middle:.6g}, is not among the rows, which go from x = {x[0]:.6g}"
            f" to {x[-1]:.6g}"
        )
        raise RowError(0, f"{fault}: measure both sides of it, or state centre")
    if not float(np.ptp(h)) > 0:
        raise RowError(last_row, "the rows are flat from end to end: they must rise somewhere")


class _FitOfRows(NamedTuple):
    """A fitted profile: its keys for a scene file, and the fitted h at any places x, with offset
    and tilt, as it was measured.
    """

    keys: dict[str, Any]
    height_at: Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class _ScaledFit:
    """A fit to points whose x and h were made dimensionless, with the origin and the units by which
    it is converted to those of the trace.

    Attributes
    ----------
    x, h
        (n,) fitted points, those within the extent, levelled [length]
    origin
        x at which dimensionless places are 0
    length_unit, height_unit
        units of dimensionless x and h [length]
    fit
        the dimensionless fit
    """

    x: Array
    h: Array
    origin: float
    length_unit: float
    height_unit: float
    fit: _Fit

    @property
    def middle(self) -> float:
        """x of the middle of the fitted profile [length]."""
        return self.origin + self.length_unit * self.fit.middle

    def heights(self, places: Array) -> Array:
        """Fitted h of the levelled trace at any places x (n,) [length].

        The dimensionless fit `fit` is h = offset + tilt (x - middle) + sum_j w_j B_j(|x - middle|),
        with basis functions B_j and weights w_j (`basis_weights`). Its x is 0 at `origin`, its h at
        the first fitted point; `length_unit` and `height_unit` are its units. `fit.problem` has the
        basis functions of its kind of profile. `flat_half_length` is 0 without a flat.
        """
        fit = self.fit
        scaled_places = (places - self.origin) / self.length_unit
        # (n, m) values of the m basis functions B_j, convex in the distance from the middle.
        basis_functions = fit.problem.basis_functions(
            np.abs(scaled_places - fit.middle), fit.flat_half_length
        )
        scaled_heights = (
            fit.offset
            + fit.tilt * (scaled_places - fit.middle)
            + basis_functions @ fit.basis_weights
        )
        return np.asarray(self.h[0] + self.height_unit * scaled_heights)


def _fit_of_rows(x: Array, h: Array, request: FitRequest) -> _FitOfRows:
    """Fit a convex profile to measured points x, h (n,) [length] by least squares, all points taken
    as they are: the keys of the profile, the record of the fit among them, and the fitted curve.

    `request` states the kind of profile, and what is known: noise, middle, extent, tilt.

    Raises
    ------
    RowError
        For too few or too many points, x that descends, points that curve down, or points on one
        side of the middle alone. One side is enough for a middle that is known, if the nearest
        point is within a tenth of the largest distance from it.
    """
    # Equal neighbours in x are allowed: a trace with few digits has several points at one x.
    RowError.refuse(np.diff(x) < 0, lambda row: f"x = {x[row]:.6g} does not ascend", 1)
    # _MOST_ROWS: 20,000 points
    if len(x) > _MOST_ROWS:
        raise RowError(
            _MOST_ROWS,
            f"{len(x):,} rows are too many for a fit of at most {_MOST_ROWS:,}: leave out all but"
            " every n-th",
        )

    # Heights minus the `tilt` of the trace as a whole, then the dimensionless fit to those points.
    trace = _levelled_trace(x, h, request)
    scaled_fit = _fit_within_extent(x, trace, request)

    def height_at(places: Array) -> Array:
        """Fitted h of the trace as it was measured, with its tilt."""
        return np.asarray(scaled_fit.heights(places) + trace.tilt * (places - x[0]))

    # Profile keys in the units of the trace, with the record of the fit.
    keys = {
        **scaled_fit.fit.keys(scaled_fit.length_unit, scaled_fit.height_unit),
        "fitted": _record_of_fit(x, trace, scaled_fit, request),
    }
    return _FitOfRows(keys, height_at)


def _fit_within_extent(x: Array, trace: _Trace, request: FitRequest) -> _ScaledFit:
    """Fit a profile to the measured points no farther from its middle than the requested extent.

    The middle (axis of symmetry) follows from the fit, and decides which points count. So the fit
    is repeated until the same points stay within the extent, 5 times at most.

    Parameters
    ----------
    x
        (n,) places of all points of the trace [length]
    trace
        the levelled points; `first_middle` is the x at which the search for the middle begins
    request
        what is fitted; `extent` is the largest distance from the middle, None for no limit
    """
    extent = request.extent or math.inf
    assumed_middle = trace.first_middle
    # _MOST_REPEATS_OF_FIT: 5 repeats
    for _ in range(_MOST_REPEATS_OF_FIT):
        # Fit to the points within the extent of the assumed middle; its own middle may differ.
        scaled_fit = _fit_about(x, trace, request, assumed_middle)
        is_within_extent = np.abs(x - assumed_middle) <= extent
        if np.array_equal(np.abs(x - scaled_fit.middle) <= extent, is_within_extent):
            break
        assumed_middle = scaled_fit.middle
    return scaled_fit


def _fit_about(
    x_of_all_rows: Array, trace: _Trace, request: FitRequest, assumed_middle: float
) -> _ScaledFit:
    """Fit a profile to the points of a trace within the requested extent of an assumed middle.

    Places and heights are made dimensionless first, by the largest distance from that middle and by
    the range of h: so no fit depends on the units of the trace. Where the middle is fitted too, the
    fitted one differs from the assumed one, which is x = 0 of the dimensionless fit.

    Parameters
    ----------
    x_of_all_rows
        (n,) places of all points of the trace [length]
    trace
        `levelled_heights` (n,); `known_middle`, None where the middle is fitted; `tilt_is_fitted`
    request
        `kind` of profile; `extent`, `noise` (standard deviation of h), `smoothing_weight` (factor
        on the squared differences of neighbouring spline weights) and `first_guess` (middle,
        half-length of the flat), None where they are not stated
    assumed_middle
        x of the axis of symmetry [length]

    Raises
    ------
    RowError
        For too few points, all of one height, or not curved upwards. For points on one side of the
        middle, unless it is known and the nearest lies within a tenth of the largest distance.
        Where the fitted middle is as far from the assumed one as the farthest point, to 2 %.
    """
    is_within_extent = np.abs(x_of_all_rows - assumed_middle) <= (request.extent or math.inf)
    x = x_of_all_rows[is_within_extent]
    h = trace.levelled_heights[is_within_extent]
    last_row = len(x_of_all_rows) - 1
    middle_is_known = trace.known_middle is not None
    _check_rows_of_fit(x, h, assumed_middle, middle_is_known, last_row)

    # Dimensionless points and noise.
    height_unit = float(np.ptp(h))
    length_unit = float(np.max(np.abs(x - assumed_middle)))
    scaled_noise = None
    if request.noise is not None:
        # Beyond these limits its square is no number.
        scaled_noise = float(np.clip(request.noise / height_unit, 1e-12, 1e6))
    fit_problem = _FitProblem(
        x=(x - assumed_middle) / length_unit,
        h=(h - h[0]) / height_unit,
        kind=request.kind,
        middle_is_fitted=not middle_is_known,
        tilt_is_fitted=trace.tilt_is_fitted,
    )

    guessed_half_length = None
    if request.first_guess is not None:
        _, half_length = request.first_guess
        guessed_half_length = half_length / length_unit
    # The dimensionless fit: middle, offset, tilt and weights of the basis functions.
    fit = fit_problem.fit(scaled_noise, request.smoothing_weight, guessed_half_length)
    # A straight line through the points bends by round-off alone: `profile_heights` are the fitted
    # heights without offset and tilt. And a middle at the last point has no points beyond.
    # _LEAST_HEIGHT_RANGE_SHARE: 1e-9; _LONGEST_HALF_LENGTH: 0.98, also the farthest middle
    if (
        np.ptp(fit.profile_heights) < _LEAST_HEIGHT_RANGE_SHARE
        or abs(fit.middle) > _LONGEST_HALF_LENGTH
    ):
        raise RowError(
            last_row,
            "the rows do not bend up: h is a gap, which grows to both sides; is its sign turned?",
        )
    return _ScaledFit(x, h, assumed_middle, length_unit, height_unit, fit)


def _record_of_fit(
    x_of_all_rows: Array, trace: _Trace, scaled_fit: _ScaledFit, request: FitRequest
) -> dict[str, Any]:
    """Record of a profile's fit for the scene file, in the units of the trace: what was fitted and
    what was stated, noise, residuals, and how far the points reach.

    A noise that is not stated is estimated from the residuals: the root of their sum of squares
    over the degrees of freedom, points minus fitted parameters.

    Parameters
    ----------
    x_of_all_rows
        (n,) places of all measured points [length]
    trace
        `tilt` that was removed before the fit; `known_middle`, None where it was fitted;
        `tilt_is_fitted`: whether a further tilt was fitted; `is_one_sided`: whether all points lie
        on one side
    scaled_fit
        `x`, `h` of the fitted points and `middle` [length]; the dimensionless `fit`, with its units
        `length_unit` and `height_unit` [length]
    request
        `kind` of profile, and `noise` [length], None where it is not stated
    """
    x = scaled_fit.x
    height_unit = scaled_fit.height_unit
    fit = scaled_fit.fit
    middle = scaled_fit.middle
    first_height = float(scaled_fit.h[0])
    # Measured minus fitted heights, both counted from the first point.
    residuals = (scaled_fit.h - scaled_fit.h[0]) - height_unit * fit.fitted_heights
    sum_of_squares = float(residuals @ residuals)
    degrees_of_freedom = max(1, len(x) - round(fit.n_effective_parameters))
    # The residuals of an exact fit are round-off: a noise of 0 would divide by 0 later.
    estimated_noise = max(math.sqrt(sum_of_squares / degrees_of_freedom), 1e-15 * height_unit)

    # How far the points reach from the middle to each side. "extent" is the smaller distance, up to
    # which points lie on both sides; where all lie on one side it is the larger.
    reach_to_left_end = middle - x[0]
    reach_to_right_end = x[-1] - middle
    larger_reach = max(reach_to_left_end, reach_to_right_end)
    smaller_reach = min(reach_to_left_end, reach_to_right_end)
    return {
        "kind": request.kind,
        "noise": estimated_noise if request.noise is None else request.noise,
        "noise_stated": request.noise is not None,
        "centre": middle,
        "centre_fitted": trace.known_middle is None,
        "tilt": trace.tilt + fit.tilt * height_unit / scaled_fit.length_unit,
        "tilt_fitted": trace.tilt_is_fitted,
        "offset": first_height
        + height_unit * fit.offset
        + trace.tilt * (middle - x_of_all_rows[0]),
        "residual": math.sqrt(sum_of_squares / len(x)),
        "freedom": degrees_of_freedom,
        "extent": larger_reach if trace.is_one_sided else smaller_reach,
        "weight": fit.smoothing_weight,
        "left_out": len(x_of_all_rows) - len(x),
    }


def _is_tilted_as_a_whole(x: Array, h: Array, kind: str) -> bool:
    """Whether measured points x, h (n,) fall from end to end, since the trace lay tilted in the
    instrument.

    The least-squares parabola of a level trace is lowest near mid-length. A trace is tilted where
    it is lowest farther from there than 0.3 of the half-length of the trace. For a `kind` "hertz"
    the limit is the half-length: a tilt of it is not fitted, so that an off-centre parabola must
    stay as it is. Points that are the right half of a profile are never tilted.
    """
    if x[-1] <= x[0] or _is_half_a_profile(x, h):
        return False
    mid_length = float(x[0] + x[-1]) / 2
    half_length = float(x[-1] - x[0]) / 2
    relative_offset = abs(_lowest_place(x, h) - mid_length) / half_length
    # _LARGEST_OFFSET_OF_LEVEL_TRACE: 0.3 of the half-length
    return relative_offset >= (1.0 if kind == "hertz" else _LARGEST_OFFSET_OF_LEVEL_TRACE)


def _is_half_a_profile(x: Array, h: Array) -> bool:
    """Whether measured points x, h (n,), all at x >= 0, are the right half of a profile: the first
    of eight parts is hardly higher than the lowest.
    """
    if len(x) < _FEWEST_ROWS or x[0] < 0:
        return False
    mean_heights = np.array([part.mean() for part in np.array_split(h, _N_PARTS_OF_TRACE)])
    return bool(
        mean_heights[0] - mean_heights.min() <= _LARGEST_RISE_SHARE_AT_MIDDLE * np.ptp(mean_heights)
    )


def fitted_again(
    profile: Any, standard_noise: Array | None = None, smoothing_factor: float = 1.0
) -> dict[str, Any] | None:
    """Repeat the fit of a fitted profile, to its measured points or to simulated ones, to see how
    uncertain the fit is: the keys of the new profile; None where no convex profile fits.

    Parameters
    ----------
    profile
        a profile of a scene that was fitted: `height` is its gap h(x), and `fitted` the record of
        the fit: measured rows, centre, offset (h at the centre), tilt, `noise` (standard deviation
        of h); `centre_fitted` and `tilt_fitted`: whether these two were fitted, not stated
    standard_noise
        (n,) random heights of standard deviation 1, one for each fitted point. Times the standard
        deviation `fitted.noise` they are added to the first fit; None: the measured points
    smoothing_factor
        factor on the smoothing weight of the first fit
    """
    record = profile.fitted
    # Places and heights of the measured points that were fitted.
    x, h = record.rows.values[record.used_rows()].T
    # With the fitted middle at 0 no noise can make points of both sides look like one half.
    x = x - record.centre
    if standard_noise is not None:
        h = record.offset + profile.height(x) + record.noise * standard_noise
        # A stated tilt is removed again before the fit, so it has to be in the points.
        if not record.tilt_fitted:
            h = h + record.tilt * x
    request = FitRequest(
        kind=record.kind,
        noise=record.noise,
        centre=None if record.centre_fitted else 0.0,
        tilt=None if record.tilt_fitted else record.tilt,
        smoothing_weight=smoothing_factor * record.weight,
        first_guess=(0.0, getattr(profile, "flat_half_length", 0.0)),
    )

    # A RowError: the points admit no convex profile.
    with contextlib.suppress(RowError):
        return _fit_of_rows(x, h, request).keys
    return None


def fitted_by_spline(profile: Any) -> dict[str, Any] | None:
    """Fit a smoothing spline to the measured points of a fitted profile, noise and tilt fitted
    again: the keys of the spline; None where no convex one fits.

    `profile.fitted` is the record of the first fit: its measured rows, the middle `centre`, and in
    `centre_fitted` whether that was fitted.
    """
    record = profile.fitted
    # Places and heights of the measured points that were fitted.
    x, h = record.rows.values[record.used_rows()].T
    request = FitRequest("smoothing_spline", centre=None if record.centre_fitted else 0.0)
    with contextlib.suppress(RowError):
        return _fit_of_rows(x - record.centre, h, request).keys
    return None


def _lowest_place(x: Array, h: Array) -> float:
    """x at which the least-squares parabola through points x, h (n,) is lowest; the mean of x where
    the parabola does not open upwards.
    """
    half_length = float(np.ptp(x)) / 2 or 1.0
    # Least squares by singular values: points that all but coincide give no warning.
    _, slope, bend = np.linalg.lstsq(
        polynomial.polyvander((x - x.mean()) / half_length, 2), h - h.mean(), rcond=None
    )[0]
    return float(x.mean() - half_length * slope / (2 * bend)) if bend > 0 else float(x.mean())


def _noise_variance(x: Array, h: Array) -> float:
    """Variance of the noise of measured heights h (n,) at places x (n,), robust to spikes.

    Of every four neighbouring points the third divided difference is squared, and divided by its
    variance for noise of variance 1. The median of these squares is divided by 0.4549, which is the
    median of the square of a standard normal number. A smooth profile hardly contributes, since its
    curvature hardly changes between neighbours. 0 where no four neighbours differ in x.

    >>> x = np.linspace(-1, 1, 2001)
    >>> (
    ...     round(_noise_variance(x, x**2 + np.random.default_rng(0).normal(0, 0.1, 2001)), 4),
    ...     _noise_variance(x, x**2) < 1e-30,
    ... )
    (0.0096, True)
    """
    places = np.lib.stride_tricks.sliding_window_view(x, 4)
    heights = np.lib.stride_tricks.sliding_window_view(h, 4)
    is_distinct = np.all(np.diff(places) > 0, axis=1)
    if not np.any(is_distinct):
        return 0.0
    # Weights of a divided difference: 1 over the product of the distances to the three other
    # places, in units of the distance from the first to the fourth.
    span_of_four = places[is_distinct, -1] - places[is_distinct, 0]
    scaled_places = places[is_distinct] / span_of_four[:, None]
    distances = scaled_places[:, :, None] - scaled_places[:, None, :] + np.eye(4)
    weights = 1 / np.prod(distances, axis=2)
    third_differences = np.sum(weights * heights[is_distinct], axis=1)
    variance_of_each_four = third_differences**2 / np.sum(weights**2, axis=1)
    # _MEDIAN_OF_SQUARED_DEVIATE: 0.4549, that of a standard normal number
    return float(np.median(variance_of_each_four)) / _MEDIAN_OF_SQUARED_DEVIATE


# Coefficients (m, 4) of curvature polynomials of u = (s/L)^2 that are nowhere negative for u >= 0,
# in ascending powers: 1, u, (u - c)^2 and u (u - c)^2. Sums approximate all such of degree 3.
_CURVATURE_POLYNOMIALS = np.concatenate(
    [
        np.eye(4)[:2],
        *(
            [[c * c, -2 * c, 1.0, 0.0], [0.0, c * c, -2 * c, 1.0]]
            for c in _DOUBLE_ROOTS_OF_CURVATURE.tolist()
        ),
    ]
)
_CURVATURE_POLYNOMIALS /= np.abs(_CURVATURE_POLYNOMIALS).max(axis=1, keepdims=True)
# Divisors that two integrations of 1, s^2, s^4 and s^6 bring: s^(k+2)/((k+1)(k+2)) of s^k.
_DIVISORS_OF_TWO_INTEGRATIONS = np.array([1 * 2, 3 * 4, 5 * 6, 7 * 8])


def _smoothing_equations(n_functions: int, smoothing_weight: float) -> Array:
    """Least-squares equations, (n, k + 1) with the right side 0 last, that keep neighbouring
    weights w_j of k functions close: root of `smoothing_weight` times their difference. None, (0, k
    + 1), where that weight is 0.
    """
    if not smoothing_weight:
        return np.zeros((0, n_functions + 1))
    differences = np.diff(np.eye(n_functions + 1)[:n_functions], axis=0)
    return np.asarray(math.sqrt(smoothing_weight) * differences)


def _non_negative_weights(equations: Array) -> Array:
    """Least-squares solution w >= 0, (k,), of equations (n, k + 1) with the right side in the last
    column. NotFoundError where the iteration does not converge.
    """
    from scipy.optimize import nnls

    n_weights = equations.shape[1] - 1
    try:
        weights, _ = nnls(equations[:, :-1], equations[:, -1], maxiter=50 * n_weights)
        return np.asarray(weights)
    except RuntimeError as reason:
        raise NotFoundError(f"no curve through the rows was found: {reason}") from reason


@dataclass(frozen=True, eq=False)
class _FitProblem:
    """Dimensionless measured points, and what is fitted to them.

    Attributes
    ----------
    x
        (n,) places, from a first guess of the middle, the largest |x| being 1
    h
        (n,) heights above the first, of range 1
    kind
        of profile: "hertz", "flat_rounded", "even_polynomial" or "smoothing_spline"
    middle_is_fitted, tilt_is_fitted
        whether the axis of symmetry and a tilt are fitted too
    """

    x: Array
    h: Array
    kind: str
    middle_is_fitted: bool
    tilt_is_fitted: bool

    @cached_property
    def tilt_penalty_factor(self) -> float:
        """Factor on the squared tilt beside the squared residuals: variance of the noise over that
        of the tilts expected.
        """
        return _noise_variance(self.x, self.h) / _DEVIATION_OF_EXPECTED_TILTS**2

    @property
    def knots(self) -> Array:
        """Distances (_N_KNOTS,) of the spline's knots from the middle; they reach beyond the points
        where the middle moves.
        """
        return np.linspace(0.0, 1.2 if self.middle_is_fitted else 1.0, _N_KNOTS)

    def basis_functions(self, s: Array, flat_half_length: float) -> Array:
        """The m basis functions B_j(s) of the profile at distances s (n,) from its middle, (n, m).

        Each has a curvature B_j'' >= 0 and B_j(0) = B_j'(0) = 0, so that sums of them with weights
        w_j >= 0 are convex. B_j'' is 1 beyond the flat, a polynomial in s^2, or for a spline a
        piecewise linear hat, 1 at knot j and 0 at all others. `flat_half_length` counts for
        "flat_rounded" alone.
        """
        # Each row of `_CURVATURE_POLYNOMIALS` holds the coefficients of 1, s^2, s^4, s^6 in a
        # curvature.
        match self.kind:
            case "hertz" | "flat_rounded":
                return np.maximum(s - flat_half_length, 0.0)[:, None] ** 2 / 2
            case "even_polynomial":
                # _DIVISORS_OF_TWO_INTEGRATIONS: 1*2, 3*4, 5*6 and 7*8, of s^2, s^4, s^6 and s^8
                integrated_powers = s[:, None] ** [2, 4, 6, 8] / _DIVISORS_OF_TWO_INTEGRATIONS
                return integrated_powers @ _CURVATURE_POLYNOMIALS.T
        # A hat is the second difference of ramps (s - knot)_+; integrated twice, of these cubes.
        knot_distance = float(self.knots[1])
        integrated_ramps = np.maximum(
            s[:, None] - np.append(self.knots, self.knots[-1] + knot_distance), 0.0
        ) ** 3 / (6 * knot_distance)
        # The hat of the first knot, s = 0, has its falling half alone.
        first_hat = s[:, None] ** 2 / 2 - integrated_ramps[:, :1] + integrated_ramps[:, 1:2]
        return np.hstack([first_hat, np.diff(integrated_ramps, 2, axis=1)])

    def fit_for(self, middle_and_half_length: Array, smoothing_weight: float) -> _Fit:
        """Least-squares fit of the profile for a given middle and half-length of the flat:

            h = offset + tilt (x - middle) + sum_j w_j B_j(|x - middle|),   w_j >= 0

        Minimised is the sum of squared residuals, plus `tilt_penalty_factor` times tilt^2, plus
        `smoothing_weight` times the squared differences of neighbouring w_j. For any w the best
        offset and tilt are known: so non-negative least squares for w alone remain.

        `x` and `h` (n,) are the dimensionless places and heights of the points. `middle_is_fitted`
        and `tilt_is_fitted` say whether these two are unknown; a fixed middle is 0.

        Parameters
        ----------
        middle_and_half_length
            the middle if it is fitted, then the half-length for a profile with a flat; so of length
            0 to 2
        smoothing_weight
            0 for no smoothing

        Raises
        ------
        NotFoundError
            Where non-negative least squares do not converge.
        """
        # The basis functions B_j at the points, (n_rows, n_functions); a row is a measured point.
        middle = float(middle_and_half_length[0]) if self.middle_is_fitted else 0.0
        flat_half_length = float(middle_and_half_length[-1]) if self.kind == "flat_rounded" else 0.0
        basis_functions = self.basis_functions(np.abs(self.x - middle), flat_half_length)
        means_of_functions = basis_functions.mean(axis=0)
        equations, tilt_of_columns = self._equations_of_weights(basis_functions)
        smoothing_equations = _smoothing_equations(basis_functions.shape[1], smoothing_weight)
        basis_weights = _non_negative_weights(np.vstack([equations, smoothing_equations]))

        # Best offset and tilt for these w, and heights of the profile alone and of the fit. The
        # squares of `roots_of_penalties` are what smoothing and tilt add to the sum of squares.
        tilt = float(tilt_of_columns[-1] - tilt_of_columns[:-1] @ basis_weights)
        profile_heights = basis_functions @ basis_weights
        offset = float(
            self.h.mean() - means_of_functions @ basis_weights + tilt * (middle - self.x.mean())
        )
        fitted_heights = offset + tilt * (self.x - middle) + profile_heights
        root_of_tilt_penalty = (
            math.sqrt(self.tilt_penalty_factor) * tilt if self.tilt_is_fitted else 0.0
        )
        roots_of_penalties = np.append(
            smoothing_equations[:, :-1] @ basis_weights, root_of_tilt_penalty
        )
        # The offset counts as a parameter, and each weight that is not 0.
        n_fitted_parameters = (
            1.0
            + self.tilt_is_fitted
            + len(middle_and_half_length)
            + np.count_nonzero(basis_weights)
        )
        return _Fit(
            problem=self,
            middle=middle,
            flat_half_length=flat_half_length,
            basis_weights=basis_weights,
            offset=offset,
            tilt=tilt,
            profile_heights=profile_heights,
            fitted_heights=fitted_heights,
            n_effective_parameters=n_fitted_parameters,
            smoothing_weight=smoothing_weight,
            residuals=np.append(fitted_heights - self.h, roots_of_penalties),
        )

    def _equations_of_weights(self, basis_functions: Array) -> tuple[Array, Array]:
        """Linear least-squares equations for the k weights w_j of a profile h = offset + tilt x +
        sum_j w_j B_j, and the best tilt of each of their columns. The offset and the tilt that are
        best for any w are already eliminated.

        `x` and `h` (n,) are places and heights of the points, dimensionless. The tilt is fitted if
        `tilt_is_fitted`, with `tilt_penalty_factor` times tilt^2 in the sum of squares; else it is
        0.

        Parameters
        ----------
        basis_functions
            (n, k) functions B_j at the points

        Returns
        -------
        equations
            (m, k + 1), m <= k + 1 where n > k + 1, the right side in the last column
        tilt_of_columns
            (k + 1,); the best tilt for any w is the last entry minus the others times w
        """
        n_points, n_functions = basis_functions.shape
        # The best offset for any w: without the means of all columns it drops out.
        x_from_mean = self.x - self.x.mean()
        equations = np.column_stack(
            [basis_functions - basis_functions.mean(axis=0), self.h - self.h.mean()]
        )
        # The best tilt for any w is linear in w: entry j is that of column j, the last that of h.
        tilt_of_columns = np.zeros(n_functions + 1)
        if self.tilt_is_fitted:
            tilt_of_columns = (
                x_from_mean @ equations / (x_from_mean @ x_from_mean + self.tilt_penalty_factor)
            )
            untilted_equations = equations - np.outer(x_from_mean, tilt_of_columns)
            equations = np.vstack(
                [untilted_equations, math.sqrt(self.tilt_penalty_factor) * tilt_of_columns]
            )
        # The triangle R of Q R has the same least squares, with as many equations as columns.
        if n_points > n_functions + 1:
            equations = np.asarray(np.linalg.qr(equations, mode="r"))
        return equations, tilt_of_columns

    def fit_from(self, first_guess: Array, smoothing_weight: float) -> _Fit:
        """Least-squares fit of the profile with the best middle and half-length of the flat, where
        these are fitted, by Gauss-Newton steps (variable projection).

        For each trial of the two, all other unknowns follow by linear least squares.

        Parameters
        ----------
        first_guess
            the middle if it is fitted, then the half-length for a profile with a flat; empty where
            neither is fitted
        smoothing_weight
            factor on the squared differences of neighbouring spline weights; 0 for no smoothing
        """
        from scipy.optimize import least_squares

        if not len(first_guess):
            return self.fit_for(first_guess, smoothing_weight)
        # `middle_is_fitted`: then the middle is between -1 and 1.
        lower_bounds = [-1.0] * self.middle_is_fitted
        upper_bounds = [1.0] * self.middle_is_fitted
        # The half-length of the flat is between 1e-9 and 0.98 (_LONGEST_HALF_LENGTH) of the largest
        # distance.
        bounds = (
            [*lower_bounds, 1e-9][: len(first_guess)],
            [*upper_bounds, _LONGEST_HALF_LENGTH][: len(first_guess)],
        )
        least_squares_solution = least_squares(
            lambda middle_and_half_length: (
                self.fit_for(middle_and_half_length, smoothing_weight).residuals
            ),
            first_guess,
            bounds=bounds,
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
        )
        return self.fit_for(least_squares_solution.x, smoothing_weight)

    def fit(
        self, noise: float | None, smoothing_weight: float | None, guessed_half_length: float | None
    ) -> _Fit:
        """Least-squares fit of the profile of this kind to the points, middle, tilt, flat and
        smoothing weight included where they are not known.

        Parameters
        ----------
        noise
            standard deviation of a height, over the range of heights; None: unknown
        smoothing_weight
            of a smoothing spline; None: that of the least expected error
        guessed_half_length
            first guess of the half-length of a flat; None: the best of 24 trials
        """
        # The middle 0, about which the points were scaled; empty where the middle is not fitted.
        first_middle = np.zeros(int(self.middle_is_fitted))
        if self.kind == "flat_rounded":
            return self.fit_from(
                self._first_guess_with_flat(first_middle, guessed_half_length), 0.0
            )
        if self.kind == "smoothing_spline":
            # _TRIAL_WEIGHTS: from 1e-9 to 1e3
            trial_weights = (
                _TRIAL_WEIGHTS.tolist() if smoothing_weight is None else [smoothing_weight]
            )
            return self._fit_with_best_smoothing(first_middle, trial_weights, noise)
        return self.fit_from(first_middle, 0.0)

    def _first_guess_with_flat(
        self, first_middle: Array, guessed_half_length: float | None
    ) -> Array:
        """First guess of a search for the middle, if it is fitted, and the half-length of a flat:
        the given half-length, or the best of 24 by the sum of squared residuals.

        Middles too are tried where a tilt is fitted, which moves the lowest place. `first_middle`
        is the middle 0 in an array of one, or empty where the middle is not fitted.
        `guessed_half_length` is over the largest distance of a point from the middle, None for no
        guess.
        """
        if guessed_half_length is not None:
            # _TRIAL_HALF_LENGTHS: 24 from 0.02 to 0.94 of the largest distance from the middle
            return np.append(
                first_middle,
                np.clip(guessed_half_length, _TRIAL_HALF_LENGTHS[0], _TRIAL_HALF_LENGTHS[-1]),
            )
        both_are_fitted = self.middle_is_fitted and self.tilt_is_fitted
        # _TRIAL_MIDDLES: seven from -0.45 to 0.45 of it
        trial_middles = _TRIAL_MIDDLES if both_are_fitted else np.zeros(1)
        trial_guesses = [
            np.append(first_middle + middle, half_length)
            for middle in trial_middles
            for half_length in _TRIAL_HALF_LENGTHS
        ]
        return min(
            trial_guesses,
            key=lambda guess: float(np.sum(self.fit_for(guess, 0.0).residuals ** 2)),
        )

    def _n_effective_parameters(self, middle: float, smoothing_weight: float) -> float:
        """How many parameters a smoothing spline about a `middle` has in effect: its basis weights,
        each less than one by the smoothing, the offset, and middle and tilt where they are fitted.

        Basis weights with smoothing are a matrix, the smoother, times those without. The sum of its
        diagonal is their effective number: without smoothing it is the unit matrix.
        `smoothing_weight` is the factor on the squared differences of neighbouring basis weights.
        """
        basis_functions = self.basis_functions(np.abs(self.x - middle), 0.0)
        gram_matrix = (basis_functions - basis_functions.mean(axis=0)).T @ basis_functions
        differences = np.diff(np.eye(len(gram_matrix)), axis=0)
        smoother_matrix = np.linalg.solve(
            gram_matrix + smoothing_weight * differences.T @ differences, gram_matrix
        )
        n_further_parameters = 1 + self.middle_is_fitted + self.tilt_is_fitted
        return n_further_parameters + float(np.trace(smoother_matrix))

    def _fit_with_best_smoothing(
        self, first_middle: Array, trial_weights: list[float], noise: float | None
    ) -> _Fit:
        """Fit a smoothing spline with each of several smoothing weights, and return the fit of the
        least expected error.

        With S the sum of squared residuals, n points and k effective parameters, that error is
        S/noise^2 + 2 k (Mallows), or S/(n - k)^2 where the noise is unknown (generalised
        cross-validation). `_n_effective_parameters` gives k.

        Parameters
        ----------
        first_middle
            first guess of the middle, (1,), or empty where the middle is not fitted
        trial_weights
            factors on the squared differences of neighbouring basis weights
        noise
            standard deviation of a height, over the range of heights; None: unknown

        Returns
        -------
        _Fit
            That of the least expected error, with its number of effective parameters.
        """
        # `x` and `h` (n,): dimensionless places and heights of the points.
        n_rows = len(self.x)
        fits = []
        expected_errors = []
        for smoothing_weight in trial_weights:
            # Fit with the best middle for this smoothing weight.
            fit = self.fit_from(first_middle, smoothing_weight)
            n_parameters = self._n_effective_parameters(fit.middle, smoothing_weight)
            sum_of_squares = float(np.sum((self.h - fit.fitted_heights) ** 2))
            if noise:
                expected_error = sum_of_squares / noise**2 + 2 * n_parameters
            else:
                expected_error = sum_of_squares / max(n_rows - n_parameters, 1e-3) ** 2
            expected_errors.append(expected_error)
            fits.append(replace(fit, n_effective_parameters=min(n_parameters, n_rows - 1.0)))
        return fits[int(np.argmin(expected_errors))]


@dataclass(frozen=True, eq=False)
class _Fit:
    """A convex profile fitted to dimensionless points.

    Attributes
    ----------
    rows
        the points, and what was fitted
    middle, flat_half_length
        x of the axis of symmetry, half-length of the flat (0 for a profile without one)
    basis_weights
        (m,) factors w_j of the basis functions, not negative
    offset, tilt
        height at the middle, slope of the trace
    profile_heights, fitted_heights
        (n,) at the points: the sum of basis functions alone, and with offset and tilt
    n_effective_parameters
        how many numbers were fitted; of a spline the basis weights count as the sum of the diagonal
        of its smoother matrix
    smoothing_weight
        factor on the squared differences of neighbouring basis weights
    residuals
        (k,) fitted minus measured heights, then the penalties of smoothing and tilt, each the root
        of what it adds to the sum of squares
    """

    problem: _FitProblem
    middle: float
    flat_half_length: float
    basis_weights: Array
    offset: float
    tilt: float
    profile_heights: Array
    fitted_heights: Array
    n_effective_parameters: float
    smoothing_weight: float
    residuals: Array

    def keys(self, length_unit: float, height_unit: float) -> dict[str, Any]:
        """The fitted profile as keys of a scene file: kind, then radius, flat, polynomial or table
        of points, in the units of the trace.

        The kind fitted is `problem.kind`; `basis_weights` w_j multiply its basis functions.
        `length_unit` and `height_unit` are the units of x and h of this fit [length]. The offset
        and the tilt are no part of the profile.
        """
        match self.problem.kind:
            case "hertz" | "flat_rounded":
                # The one basis function is s^2/2: its weight is the curvature.
                radius = length_unit**2 / height_unit / float(self.basis_weights[0])
                if self.problem.kind == "hertz":
                    return {"kind": "hertz", "radius": radius}
                return {
                    "kind": "flat_rounded",
                    "radius": radius,
                    "flat_half_length": length_unit * self.flat_half_length,
                }
            case "even_polynomial":
                # Coefficients of the curvature in powers of (s/L)^2; integrated twice below.
                # _CURVATURE_POLYNOMIALS: coefficients of the basis curvatures
                curvature_coefficients = self.basis_weights @ _CURVATURE_POLYNOMIALS
                rises = height_unit * curvature_coefficients / _DIVISORS_OF_TWO_INTEGRATIONS
                return {"kind": "polynomial", "length": length_unit, "rises": tuple(rises.tolist())}

        # A smoothing spline becomes a table of points on it.
        # _N_SPLINE_ROWS: 61; `knots` are distances of the spline's knots from the middle
        distances = np.linspace(0.0, self.problem.knots[-1], _N_SPLINE_ROWS)
        heights = self.problem.basis_functions(distances, 0.0) @ self.basis_weights
        return {
            "kind": "tabulated",
            "points": np.column_stack([length_unit * distances, height_unit * heights]),
        }
