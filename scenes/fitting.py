"""Curves through noisy measured rows: parabola, flat with rounded edges, even polynomial, smoothing
spline; all convex.

# notation: x0 centre, s = |x - x0|, L the largest s, kappa = h'' >= 0, b half-length of a flat,
#           sigma noise of h, alpha tilt: slope at which the trace lay in the instrument

Each is a sum of kappa's with factors that are not negative, so that the contact can't split:

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
from scenes.spikes import STANDS_OUT, rows_that_stand_out

# Rows that a fit needs: it has up to six numbers, and the noise may have to come from what is left.
_FEWEST_ROWS = 8
_MOST_ROWS = 20_000
# A middle that is given may lie beside the rows by this share of their reach: rows of one side need
# not begin at x = 0.
_SHARE_BESIDE_ROWS = 0.1
# Parts of the rows; the first has risen where it lies by more than this share of all heights above
# the lowest.
_N_PARTS = 8
_SHARE_OF_RISE = 0.05
# Rise of a curve, over that of the rows, below which it is none.
_LEAST_BEND = 1e-9
# Fits about another middle, by which other rows lie within the extent.
_MOST_PASSES = 5
# Of half the length of the trace: its middle lies no farther from that of the contact.
_LARGEST_OFFSET = 0.3
# Of the rows: more that stand out are no spikes. Of the largest residual: less is round-off error.
_SHARE_OF_SPIKES = 0.05
_ROUND_OFF = 1e-9
# Of the rows: fewer heights that differ are steps of the last digit.
_SHARE_OF_DISTINCT = 0.7
# Places c, in L^2, of the polynomials (u - c)^2.
_TOUCHING_PLACES = np.concatenate([np.linspace(0.0, 1.0, 21), np.geomspace(1.1, 10.0, 12)])
# Knots of the spline; rows that it leaves behind; weights that are tried, over that at which rows
# and steps count alike.
_N_KNOTS = 31
_N_SPLINE_ROWS = 61
_TRIAL_WEIGHTS = np.logspace(-9, 3, 19)
# Half-lengths of the flat, in L, of which the best begins the search; the longest.
_TRIAL_HALF_LENGTHS = np.linspace(0.02, 0.94, 24)
_LONGEST_HALF_LENGTH = 0.98
# Middles, in L from that of a parabola through the rows, with which the half-lengths are tried
# where a tilt has moved the parabola.
_TRIAL_MIDDLES = np.linspace(-0.45, 0.45, 7)
# Median of the square of a normal deviate.
_MEDIAN_OF_SQUARE = 0.4549
# Standard deviation of the tilts that are expected, over the rise of the rows over their length.
_EXPECTED_TILT = 0.1


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
        x of the middle; None: fitted
    extent
        largest distance from the middle of the rows that count; None: all count
    tilt
        slope of the trace; None: fitted where the rows can show it
    weight
        of the smoothing; None: that of the least expected error
    guess
        middle and half-length of the flat at which the search begins; None: the best of many
    """

    kind: str
    noise: float | None = None
    centre: float | None = None
    extent: float | None = None
    tilt: float | None = None
    weight: float | None = None
    guess: tuple[float, float] | None = None


def fitted_keys(x: Array, h: Array, request: FitRequest) -> dict[str, Any]:
    """Fit a profile to a measured trace x, h (n,) after removing spikes: the keys of the profile in
    a scene file, with a record of the fit under `fitted`.

    A spike is a single row that stands out from its neighbours and from the fit. The fit is
    repeated without such rows. `request` states the kind of profile, and what is known before.

    Raises
    ------
    RowError
        For too few or too many rows, x that descends, rows that do not bend up, or rows on one side
        of the middle alone.
    """
    candidate_rows = _spikes_of(x, h)
    row_numbers = np.arange(len(x))
    fit = _fit_of_rows(np.delete(x, candidate_rows), np.delete(h, candidate_rows), request)
    for _ in range(_MOST_PASSES):
        rows_in_fit = np.delete(row_numbers, candidate_rows)
        rows_apart = _rows_far_from_fit(h[rows_in_fit] - fit.curve(x[rows_in_fit]))
        if not len(rows_apart) or len(candidate_rows) + len(rows_apart) > _SHARE_OF_SPIKES * len(x):
            break
        candidate_rows = np.sort(np.append(candidate_rows, rows_in_fit[rows_apart]))
        fit = _fit_of_rows(np.delete(x, candidate_rows), np.delete(h, candidate_rows), request)
    # A corner of the shape stands out from its neighbours, but not from the fit: it stays.
    distances_from_fit = np.abs(h[candidate_rows] - fit.curve(x[candidate_rows]))
    spikes = candidate_rows[distances_from_fit > STANDS_OUT * fit.keys["fitted"]["noise"]]
    if len(spikes) < len(candidate_rows):
        fit = _fit_of_rows(np.delete(x, spikes), np.delete(h, spikes), request)
    if len(spikes):
        fit.keys["fitted"]["spikes"] = tuple((spikes + 1).tolist())
    return fit.keys


def _rows_far_from_fit(residuals: Array) -> NDArray[np.int64]:
    """Numbers of the rows (m,) whose residual is far larger than the standard deviation of all, and
    twice as large as those of both neighbours: spikes, not noise.
    """
    sizes = np.abs(residuals)
    sigma = float(np.median(sizes)) / math.sqrt(
        _MEDIAN_OF_SQUARE
    )  # standard deviation, robust to spikes
    if not sigma > _ROUND_OFF * float(np.max(sizes)):
        return np.array([], dtype=np.int64)
    neighbour_sizes = np.maximum(np.append(sizes[1:], 0.0), np.append(0.0, sizes[:-1]))
    return np.flatnonzero((sizes > STANDS_OUT * sigma) & (sizes > 2 * neighbour_sizes))


def _spikes_of(x: Array, h: Array) -> NDArray[np.int64]:
    """Rows (m,) that stand out from their neighbours; none of rows that are not in order."""
    if not _FEWEST_ROWS < len(x) <= _MOST_ROWS or np.any(np.diff(x) < 0):
        return np.array([], dtype=np.int64)
    sigma = max(math.sqrt(_variance(x, h)), 1e-12 * float(np.ptp(h)))
    levels = np.unique(h)
    if (
        1 < len(levels) < _SHARE_OF_DISTINCT * len(h)
    ):  # noise hides below the step of the last digit
        sigma = max(sigma, float(np.min(np.diff(levels))))
    return rows_that_stand_out(x, h, sigma) if sigma > 0 else np.array([], dtype=np.int64)


class _Trace(NamedTuple):
    """A trace before a fit: its heights h (n,) without the slope `tilt`; the centre where it is
    given or rows of one side imply it, else None; whether all rows lie on one side, whether a tilt
    is fitted, and the middle that the fit begins from.
    """

    h: Array
    tilt: float
    centre_given: float | None
    one_sided: bool
    tilt_fitted: bool
    first_middle: float


def _trace_of(x: Array, h: Array, request: FitRequest) -> _Trace:
    """Prepare a measured trace x, h (n,) for a fit: remove its tilt where it falls from end to end,
    and decide where the middle may be and whether middle and tilt are fitted.

    `request` states the kind of profile, and what is known before: middle, tilt, a first guess.
    """
    tilt = request.tilt or 0.0
    level_h = h - tilt * (x - x[0])
    centre_given = request.centre
    may_be_tilted = request.tilt is None and centre_given is None and request.guess is None
    if may_be_tilted and _falls_from_end_to_end(x, h, request.kind):
        tilt = float(np.polyfit(x - x[0], h, 1)[0])
        level_h = h - tilt * (x - x[0])
    if centre_given is None and _begins_in_the_middle(x, level_h):
        centre_given = 0.0
    one_sided = centre_given is not None and x[0] >= centre_given
    is_free_parabola = request.kind == "hertz" and centre_given is None
    tilt_fitted = request.tilt is None and not one_sided and not is_free_parabola
    first_middle = _middle(x, level_h) if centre_given is None else centre_given
    if request.guess is not None and centre_given is None:
        first_middle = request.guess[0]
    elif tilt_fitted and centre_given is None and not x[0] < first_middle < x[-1]:
        # So much tilt that a parabola has its least value beyond the rows.
        first_middle = float(x[0] + x[-1]) / 2
    return _Trace(level_h, tilt, centre_given, one_sided, tilt_fitted, first_middle)


def _check_rows_of_fit(
    x: Array, h: Array, middle: float, centre_given: float | None, last_row: int
) -> None:
    """Refuse rows x, h (n,) to which no profile can be fitted: too few, flat from end to end, or
    with the middle of the profile outside them.

    Parameters
    ----------
    middle
        x about which the profile is fitted
    centre_given
        the same where the user stated it, else None; rows of one side may then begin beside it
    last_row
        number of the last row of the trace, for the message

    Raises
    ------
    RowError
        With the row, and what to do.
    """
    n_places = len(np.unique(x))
    if n_places < _FEWEST_ROWS:
        raise RowError(
            last_row,
            f"{n_places} rows within the extent are too few for a fit: at least {_FEWEST_ROWS} are"
            " needed",
        )
    distances = np.abs(x - middle)
    is_far = centre_given is None or np.min(distances) > _SHARE_BESIDE_ROWS * float(
        np.max(distances)
    )
    if not x[0] <= middle < x[-1] and is_far:
        fault = (
            f"the middle, x = {middle:.6g}, is not among the rows, which go from x = {x[0]:.6g}"
            f" to {x[-1]:.6g}"
        )
        raise RowError(0, f"{fault}: measure both sides of it, or state centre")
    if not float(np.ptp(h)) > 0:
        raise RowError(last_row, "the rows are flat from end to end: they must rise somewhere")


class _FitOfRows(NamedTuple):
    """Keys of the profile, and the curve over x with its offset and tilt."""

    keys: dict[str, Any]
    curve: Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class _ScaledFit:
    """A fit in units of its rows, with what it takes to return to those of the trace.

    Attributes
    ----------
    x, h
        (n,) rows that were fitted: those within the extent
    origin
        x at which scaled places are 0
    length, height
        units of x and of h
    best
        the fit, scaled
    """

    x: Array
    h: Array
    origin: float
    length: float
    height: float
    best: _Fit

    @property
    def middle(self) -> float:
        """x of the middle of the fitted shape."""
        return self.origin + self.length * self.best.centre

    def heights(self, places: Array) -> Array:
        """Fitted h at any places, as the levelled trace has it."""
        best = self.best
        scaled_places = (places - self.origin) / self.length
        columns = best.rows.columns(np.abs(scaled_places - best.centre), best.flat_half_length)
        shape = best.offset + best.tilt * (scaled_places - best.centre) + columns @ best.w
        return np.asarray(self.h[0] + self.height * shape)


def _fit_of_rows(x: Array, h: Array, request: FitRequest) -> _FitOfRows:
    """Fit a profile to measured rows x, h (n,) by least squares: the keys of the profile in a scene
    file, with a record of the fit, and the fitted curve over x.

    `request` states the kind of profile, and what is known before: noise, middle, extent, tilt.

    Raises
    ------
    RowError
        For too few or too many rows, x that descends, rows that do not bend up, or rows on one side
        of the middle alone.
    """
    # a trace with few digits has rows at one x
    RowError.refuse(np.diff(x) < 0, lambda row: f"x = {x[row]:.6g} does not ascend", 1)
    if len(x) > _MOST_ROWS:
        raise RowError(
            _MOST_ROWS,
            f"{len(x):,} rows are too many for a fit of at most {_MOST_ROWS:,}: leave out all but"
            " every n-th",
        )
    trace = _trace_of(x, h, request)
    scaled_fit = _fit_within_extent(x, trace, request)

    def curve(places: Array) -> Array:
        """Fitted h of the trace as it was measured, with its tilt."""
        return np.asarray(scaled_fit.heights(places) + trace.tilt * (places - x[0]))

    keys = {
        **scaled_fit.best.keys(scaled_fit.length, scaled_fit.height),
        "fitted": _record_of_fit(x, trace, scaled_fit, request),
    }
    return _FitOfRows(keys, curve)


def _fit_within_extent(x: Array, trace: _Trace, request: FitRequest) -> _ScaledFit:
    """Fit the rows of a trace that lie within the requested extent of the middle.

    The middle follows from the fit, and with another middle other rows lie within the extent. So
    the fit is repeated until the rows stay, five times at most.
    """
    reach = request.extent or math.inf
    origin = trace.first_middle
    for _ in range(_MOST_PASSES):
        scaled_fit = _fit_about(x, trace, request, origin)
        is_in_reach = np.abs(x - origin) <= reach
        if np.array_equal(np.abs(x - scaled_fit.middle) <= reach, is_in_reach):
            break
        origin = scaled_fit.middle
    return scaled_fit


def _fit_about(
    x_of_all_rows: Array, trace: _Trace, request: FitRequest, origin: float
) -> _ScaledFit:
    """Fit the rows of a trace that lie within the requested extent of x = `origin`, in units of
    these rows, so that no result depends on the units of the trace.

    Raises
    ------
    RowError
        For too few rows, flat rows, rows that do not enclose the middle or do not bend up.
    """
    is_in_reach = np.abs(x_of_all_rows - origin) <= (request.extent or math.inf)
    x = x_of_all_rows[is_in_reach]
    h = trace.h[is_in_reach]
    last_row = len(x_of_all_rows) - 1
    _check_rows_of_fit(x, h, origin, trace.centre_given, last_row)
    height = float(np.ptp(h))
    length = float(np.max(np.abs(x - origin)))
    noise_over_height = None
    if request.noise is not None:
        # Beyond these limits its square is no number.
        noise_over_height = float(np.clip(request.noise / height, 1e-12, 1e6))
    scaled_rows = _Rows(
        (x - origin) / length,
        (h - h[0]) / height,
        request.kind,
        trace.centre_given is None,
        trace.tilt_fitted,
    )
    flat_half_length = None if request.guess is None else request.guess[1] / length
    best_fit = scaled_rows.fit(noise_over_height, request.weight, flat_half_length)
    # Rows on a straight line bend by round-off alone.
    if np.ptp(best_fit.shape) < _LEAST_BEND or abs(best_fit.centre) > _LONGEST_HALF_LENGTH:
        raise RowError(
            last_row,
            "the rows do not bend up: h is a gap, which grows to both sides; is its sign turned?",
        )
    return _ScaledFit(x, h, origin, length, height, best_fit)


def _record_of_fit(
    x_of_all_rows: Array, trace: _Trace, scaled_fit: _ScaledFit, request: FitRequest
) -> dict[str, Any]:
    """Record of a fit for the scene file: middle, tilt, offset, noise, extent, smoothing, and how
    many rows were left out; lengths in units of the trace.

    Without a stated noise it is the standard deviation of the residuals, by the degrees of freedom
    that the fit leaves.
    """
    x = scaled_fit.x
    height = scaled_fit.height
    best_fit = scaled_fit.best
    middle = scaled_fit.middle
    first_height = float(scaled_fit.h[0])
    residuals = (scaled_fit.h - scaled_fit.h[0]) - height * best_fit.curve
    sum_of_squares = float(residuals @ residuals)
    freedom = max(1, len(x) - round(best_fit.effective_numbers))
    estimated_noise = max(math.sqrt(sum_of_squares / freedom), 1e-15 * height)
    extents = (middle - x[0], x[-1] - middle)  # to the left and to the right
    return {
        "kind": request.kind,
        "noise": estimated_noise if request.noise is None else request.noise,
        "noise_stated": request.noise is not None,
        "centre": middle,
        "centre_fitted": trace.centre_given is None,
        "tilt": trace.tilt + best_fit.tilt * height / scaled_fit.length,
        "tilt_fitted": trace.tilt_fitted,
        "offset": first_height
        + height * best_fit.offset
        + trace.tilt * (middle - x_of_all_rows[0]),
        "residual": math.sqrt(sum_of_squares / len(x)),
        "freedom": freedom,
        "extent": max(extents) if trace.one_sided else min(extents),
        "weight": best_fit.weight,
        "left_out": len(x_of_all_rows) - len(x),
    }


def _falls_from_end_to_end(x: Array, h: Array, kind: str) -> bool:
    """Whether a measured trace x, h (n,) is tilted as a whole: a parabola through it has its least
    value far from the middle of the rows.

    Far is beyond the last row for a profile of the `kind` "hertz", whose tilt is not fitted; for
    others 0.3 of half the length, since a tilt is fitted to what is left. Rows that begin in the
    middle of the contact are not tilted.
    """
    if x[-1] <= x[0] or _begins_in_the_middle(x, h):
        return False
    from_middle = abs(_middle(x, h) - float(x[0] + x[-1]) / 2) / (float(x[-1] - x[0]) / 2)
    return from_middle >= (1.0 if kind == "hertz" else _LARGEST_OFFSET)


def _begins_in_the_middle(x: Array, h: Array) -> bool:
    """Whether rows at x >= 0 are those of one side: their first part is hardly higher than the
    lowest.
    """
    if len(x) < _FEWEST_ROWS or x[0] < 0:
        return False
    parts = np.array([part.mean() for part in np.array_split(h, _N_PARTS)])
    return bool(parts[0] - parts.min() <= _SHARE_OF_RISE * np.ptp(parts))


def fitted_again(
    profile: Any, noise: Array | None = None, smoothing: float = 1.0
) -> dict[str, Any] | None:
    """Repeat the fit of a profile, to its own rows or to a simulated second measurement, to see how
    uncertain the fit is: the keys of the new profile; None where the rows then bend down.

    Parameters
    ----------
    profile
        a profile with the record of its fit, `fitted`
    noise
        (n,) random errors of the rows over their standard deviation: the second measurement is
        the fitted curve with these errors; None for the rows themselves
    smoothing
        factor on the smoothing of the first fit
    """
    fitted = profile.fitted
    x, h = fitted.rows.values[fitted.used_rows()].T
    x = x - fitted.centre  # so that rows of both sides are such whatever their noise
    if noise is not None:
        h = fitted.offset + profile.height(x) + fitted.noise * noise
        # A fitted tilt is found again from rows without it; a given one has to be in them.
        if not fitted.tilt_fitted:
            h = h + fitted.tilt * x
    request = FitRequest(
        kind=fitted.kind,
        noise=fitted.noise,
        centre=None if fitted.centre_fitted else 0.0,
        tilt=None if fitted.tilt_fitted else fitted.tilt,
        weight=smoothing * fitted.weight,
        guess=(0.0, getattr(profile, "flat_half_length", 0.0)),
    )
    with contextlib.suppress(RowError):
        return _fit_of_rows(x, h, request).keys
    return None


def fitted_by_spline(profile: Any) -> dict[str, Any] | None:
    """Keys of the smoothing spline through the rows of a profile with `fitted`, its noise and tilt
    found again; None if unfit.
    """
    fitted = profile.fitted
    x, h = fitted.rows.values[fitted.used_rows()].T
    request = FitRequest("smoothing_spline", centre=None if fitted.centre_fitted else 0.0)
    with contextlib.suppress(RowError):
        return _fit_of_rows(x - fitted.centre, h, request).keys
    return None


def _middle(x: Array, h: Array) -> float:
    """Where the parabola of least squares has its least value; the mean of x where it has none."""
    scale = float(np.ptp(x)) / 2 or 1.0
    # Rows that all but coincide have no parabola, and no warning either.
    _, slope, bend = np.linalg.lstsq(
        polynomial.polyvander((x - x.mean()) / scale, 2), h - h.mean(), rcond=None
    )[0]
    return float(x.mean() - scale * slope / (2 * bend)) if bend > 0 else float(x.mean())


def _variance(x: Array, h: Array) -> float:
    """Variance of the noise of heights h (n,) at places x (n,), from divided third differences of
    four neighbouring rows: the median of their squares, scaled.

    A smooth shape hardly contributes, since its curvature hardly changes between neighbours.

    >>> x = np.linspace(-1, 1, 2001)
    >>> (
    ...     round(_variance(x, x**2 + np.random.default_rng(0).normal(0, 0.1, 2001)), 4),
    ...     _variance(x, x**2) < 1e-30,
    ... )
    (0.0096, True)
    """
    places = np.lib.stride_tricks.sliding_window_view(x, 4)
    heights = np.lib.stride_tricks.sliding_window_view(h, 4)
    is_distinct = np.all(np.diff(places) > 0, axis=1)
    if not np.any(is_distinct):
        return 0.0
    # Weights of a divided difference: 1 over the product of the distances to the other places, in
    # units of the widest.
    places = places[is_distinct] / (places[is_distinct, -1] - places[is_distinct, 0])[:, None]
    distances = places[:, :, None] - places[:, None, :] + np.eye(4)
    weights = 1 / np.prod(distances, axis=2)
    differences = np.sum(weights * heights[is_distinct], axis=1) ** 2 / np.sum(weights**2, axis=1)
    return float(np.median(differences)) / _MEDIAN_OF_SQUARE


# Coefficients (m, 4) of polynomials in u that are nowhere negative for u >= 0 and span all such: 1,
# u, (u - c)^2 and u (u - c)^2.
_BEND_POLYNOMIALS = np.concatenate(
    [
        np.eye(4)[:2],
        *(
            [[c * c, -2 * c, 1.0, 0.0], [0.0, c * c, -2 * c, 1.0]]
            for c in _TOUCHING_PLACES.tolist()
        ),
    ]
)
_BEND_POLYNOMIALS /= np.abs(_BEND_POLYNOMIALS).max(axis=1, keepdims=True)
# What two integrals make of 1, u, u^2 and u^3, over s^2.
_INTEGRAL_FACTORS = np.array([1 * 2, 3 * 4, 5 * 6, 7 * 8])


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows in units in which |x| and the range of h are 1, x (n,) counted from a first guess of the
    middle, and what is fitted.
    """

    x: Array
    h: Array
    kind: str
    centred: bool
    """Whether the middle is fitted too."""
    tilted: bool
    """Whether the tilt is fitted too."""

    @cached_property
    def tilt_weight(self) -> float:
        """Of the square of the tilt against those of the residuals: variance of the noise over that
        of the tilts expected.
        """
        return _variance(self.x, self.h) / _EXPECTED_TILT**2

    @property
    def knots(self) -> Array:
        """Of the spline: a little beyond the rows where their middle moves."""
        return np.linspace(0.0, 1.2 if self.centred else 1.0, _N_KNOTS)

    def columns(self, s: Array, flat_half_length: float) -> Array:
        """Basis functions B_j(s) of the shape at n distances s from the middle, (n, m): the
        fitted shape is a sum of them with weights that are not negative.

        They are a parabola beyond a flat, even polynomials, or cubic splines whose curvature is a
        hat around each knot. `flat_half_length` counts for the first kind alone.
        """
        match self.kind:
            case "hertz" | "flat_rounded":
                return np.maximum(s - flat_half_length, 0.0)[:, None] ** 2 / 2
            case "even_polynomial":
                return (s[:, None] ** [2, 4, 6, 8] / _INTEGRAL_FACTORS) @ _BEND_POLYNOMIALS.T
        # Sums of (s - t)^3 above knots t, the primitives of a corner of kappa; the first hat falls
        # from the middle on.
        knot_distance = float(self.knots[1])
        corner_columns = np.maximum(
            s[:, None] - np.append(self.knots, self.knots[-1] + knot_distance), 0.0
        ) ** 3 / (6 * knot_distance)
        curvature_column = s[:, None] ** 2 / 2 - corner_columns[:, :1] + corner_columns[:, 1:2]
        return np.hstack([curvature_column, np.diff(corner_columns, 2, axis=1)])

    def at(self, z: Array, weight: float) -> _Fit:
        """Least-squares fit of the shape for a given middle and half-length of the flat:

            h = offset + tilt (x - middle) + sum_j w_j B_j(|x - middle|),   w_j >= 0

        A multiple of the squared tilt is added, and `weight` times the squared differences of
        neighbouring w_j (smoothing). The best offset and tilt for any w are put in first, so that
        non-negative least squares for w alone remain.

        Parameters
        ----------
        z
            middle, where it is fitted, then half-length of the flat, for a shape with a flat
        weight
            of the smoothing, 0 for none
        """
        from scipy.optimize import nnls

        centre = float(z[0]) if self.centred else 0.0
        flat_half_length = float(z[-1]) if self.kind == "flat_rounded" else 0.0
        columns = self.columns(np.abs(self.x - centre), flat_half_length)
        column_means = columns.mean(axis=0)
        n_rows, n_columns = columns.shape
        x_from_mean = self.x - self.x.mean()
        columns_and_heights = np.column_stack([columns - column_means, self.h - self.h.mean()])
        # The best tilt for any w is linear in w: put in, it leaves a problem for w alone.
        tilts = np.zeros(n_columns + 1)
        if self.tilted:
            tilts = (
                x_from_mean @ columns_and_heights / (x_from_mean @ x_from_mean + self.tilt_weight)
            )
            table_without_tilt = columns_and_heights - np.outer(x_from_mean, tilts)
            columns_and_heights = np.vstack(
                [table_without_tilt, math.sqrt(self.tilt_weight) * tilts]
            )
        if n_rows > n_columns + 1:  # a triangle of as many rows as columns is enough
            columns_and_heights = np.asarray(np.linalg.qr(columns_and_heights, mode="r"))
        smoothing_rows = np.zeros((0, n_columns + 1))
        if weight:
            smoothing_rows = math.sqrt(weight) * np.diff(np.eye(n_columns + 1)[:n_columns], axis=0)
        equations = np.vstack([columns_and_heights, smoothing_rows])
        try:
            w = nnls(equations[:, :-1], equations[:, -1], maxiter=50 * n_columns)[0]
        except RuntimeError as reason:
            raise NotFoundError(f"no curve through the rows was found: {reason}") from reason
        tilt = float(tilts[-1] - tilts[:-1] @ w)
        shape_heights = columns @ w
        offset = float(self.h.mean() - column_means @ w + tilt * (centre - self.x.mean()))
        curve_heights = offset + tilt * (self.x - centre) + shape_heights
        tilt_residual = math.sqrt(self.tilt_weight) * tilt if self.tilted else 0.0
        penalty_residuals = np.append(smoothing_rows[:, :-1] @ w, tilt_residual)
        return _Fit(
            rows=self,
            centre=centre,
            flat_half_length=flat_half_length,
            w=w,
            offset=offset,
            tilt=tilt,
            shape=shape_heights,
            curve=curve_heights,
            effective_numbers=1.0 + self.tilted + len(z) + np.count_nonzero(w),
            weight=weight,
            residuals=np.append(curve_heights - self.h, penalty_residuals),
        )

    def best(self, start: Array, weight: float) -> _Fit:
        """Least-squares fit of the shape with the best middle and half-length of the flat, by
        Gauss-Newton steps (variable projection).

        `start` is a first guess of these two, or of the one that is fitted, or empty; `weight` is
        that of the smoothing.
        """
        from scipy.optimize import least_squares

        if not len(start):
            return self.at(start, weight)
        lower_bounds = [-1.0] * self.centred
        upper_bounds = [1.0] * self.centred
        bounds = (
            [*lower_bounds, 1e-9][: len(start)],
            [*upper_bounds, _LONGEST_HALF_LENGTH][: len(start)],
        )
        minimum = least_squares(
            lambda z: self.at(z, weight).residuals,
            start,
            bounds=bounds,
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
        )
        return self.at(minimum.x, weight)

    def fit(
        self, noise: float | None, weight: float | None, flat_half_length: float | None
    ) -> _Fit:
        """The least-squares fit of the shape to the rows; of a smoothing spline that with the
        smoothing of the least expected error.

        Parameters
        ----------
        noise
            standard deviation of a height, over the range of heights; None: unknown
        weight
            of the smoothing; None: several are tried
        flat_half_length
            first guess of the half-length of a flat, if there is one
        """
        no_shift = np.zeros(int(self.centred))
        if self.kind == "flat_rounded":
            return self.best(self._start_with_flat(no_shift, flat_half_length), 0.0)
        if self.kind == "smoothing_spline":
            weights = _TRIAL_WEIGHTS.tolist() if weight is None else [weight]
            return self._smoothed(no_shift, weights, noise)
        return self.best(no_shift, 0.0)

    def _start_with_flat(self, no_shift: Array, flat_half_length: float | None) -> Array:
        """First guess of the middle, where it is fitted, and the half-length of a flat: as given,
        or the best of a grid of half-lengths (and middles, where a tilt is fitted too).

        `no_shift` is the middle 0 of the rows, or empty where the middle is given.
        """
        if flat_half_length is not None:
            return np.append(
                no_shift, np.clip(flat_half_length, _TRIAL_HALF_LENGTHS[0], _TRIAL_HALF_LENGTHS[-1])
            )
        trial_middles = _TRIAL_MIDDLES if self.centred and self.tilted else np.zeros(1)
        trial_starts = [
            np.append(no_shift + middle, trial_half_length)
            for middle in trial_middles
            for trial_half_length in _TRIAL_HALF_LENGTHS
        ]
        return min(
            trial_starts, key=lambda start: float(np.sum(self.at(start, 0.0).residuals ** 2))
        )

    def _smoothed(self, start: Array, weights: list[float], noise: float | None) -> _Fit:
        """The smoothing spline whose weight of smoothing, of several, has the least expected error.

        With S the sum of squared residuals, n rows and k effective numbers of the fit (trace of its
        smoother matrix), that error is S/noise^2 + 2 k (Mallows), or S/(n - k)^2 where the noise is
        unknown (generalised cross-validation).

        Parameters
        ----------
        start
            first guess of the middle, or empty where that is given
        weights
            of the smoothing, to be tried
        noise
            standard deviation of a height, over the range of heights
        """
        n_rows = len(self.x)
        fits = []
        expected_errors = []
        for smoothing in weights:
            candidate = self.best(start, smoothing)
            columns = self.columns(np.abs(self.x - candidate.centre), 0.0)
            normal_matrix = (columns - columns.mean(axis=0)).T @ columns
            differences = np.diff(np.eye(len(normal_matrix)), axis=0)
            smoother = np.linalg.solve(
                normal_matrix + smoothing * differences.T @ differences, normal_matrix
            )
            effective_numbers = 1 + self.centred + self.tilted + float(np.trace(smoother))
            sum_of_squares = float(np.sum((self.h - candidate.curve) ** 2))
            if noise:
                expected_error = sum_of_squares / noise**2 + 2 * effective_numbers
            else:
                expected_error = sum_of_squares / max(n_rows - effective_numbers, 1e-3) ** 2
            expected_errors.append(expected_error)
            fits.append(replace(candidate, effective_numbers=min(effective_numbers, n_rows - 1.0)))
        return fits[int(np.argmin(expected_errors))]


@dataclass(frozen=True, eq=False)
class _Fit:
    """A fitted shape in units of its rows.

    Attributes
    ----------
    rows
        what was fitted
    centre, flat_half_length
        middle of the shape, half-length of its flat
    w
        (m,) weights of the basis functions, not negative
    offset, tilt
        height of the middle, slope
    shape, curve
        (n,) at the rows: the sum of basis functions alone, and with offset and tilt
    effective_numbers
        how many numbers were fitted; of a spline the trace of its smoother matrix
    weight
        of the smoothing
    residuals
        (k,) curve minus rows, then smoothing and tilt as the fit weighs them
    """

    rows: _Rows
    centre: float
    flat_half_length: float
    w: Array
    offset: float
    tilt: float
    shape: Array
    curve: Array
    effective_numbers: float
    weight: float
    residuals: Array

    def keys(self, length: float, height: float) -> dict[str, Any]:
        """The fitted profile as a table of keys for a scene file: radius, flat, polynomial or
        table of points.

        `length` is the unit of x in this fit, `height` that of h [length].
        """
        match self.rows.kind:
            case "hertz":
                return {"kind": "hertz", "radius": length**2 / height / float(self.w[0])}
            case "flat_rounded":
                radius = length**2 / height / float(self.w[0])
                return {
                    "kind": "flat_rounded",
                    "radius": radius,
                    "flat_half_length": length * self.flat_half_length,
                }
            case "even_polynomial":
                return {
                    "kind": "polynomial",
                    "length": length,
                    "rises": tuple(
                        (height * (self.w @ _BEND_POLYNOMIALS) / _INTEGRAL_FACTORS).tolist()
                    ),
                }
        x = np.linspace(0.0, self.rows.knots[-1], _N_SPLINE_ROWS)
        return {
            "kind": "tabulated",
            "points": np.column_stack([length * x, height * (self.rows.columns(x, 0.0) @ self.w)]),
        }
