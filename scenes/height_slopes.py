"""Slope h'(x) of a profile whose height h(x) is given by a function only, and the errors of load
and stiffness that round-off in its values causes.

A derivative of a Chebyshev series multiplies the round-off in coefficient k by k^2. So each series
is fitted by least squares to many more values than it has coefficients, and coefficients within
their round-off are dropped. The standard deviation of the values' round-off is that of the
residuals of a series of full degree. A coefficient fitted to n values has sqrt(2/n) of it.

Near x = 0 a height such as R - sqrt(R^2 - x^2) is a difference of larger numbers, with few digits
of its own. There one polynomial in x^2 is fitted from 0 on, as far out as one resolves h.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from scenes.array_types import Array, Mask
from scenes.chebyshev import (
    CHEBYSHEV_DEGREE,
    PiecewiseSeries,
    UnresolvedError,
    piecewise_series_of,
    truncation_error,
)

Function = Callable[[Array], Array]

# Number of values that a series is fitted to: on an interval, and of the polynomial in x^2. A
# coefficient has 6 % and 2 % of the round-off of one value.
_SAMPLES_OF_INTERVAL = 512
_SAMPLES_OF_POLYNOMIAL = 4096
# A coefficient is significant from so many standard deviations of its round-off on. Round-off is no
# perfect chance: above 4 some is left, above 8 none was seen; what is dropped with it costs 1e-15
# of a load.
_DEVIATIONS_OF_SIGNIFICANT_TERM = 8.0
# So many standard deviations are stated as error.
_DEVIATIONS_IN_STATED_ERROR = 4.0
# Last coefficients up to so many standard deviations are explained by round-off.
_DEVIATIONS_OF_EXPLAINED_TERM = 6.0
# Largest error of a load, over the load: beyond, a height is too rough to have a slope.
_LARGEST_RELATIVE_LOAD_ERROR = 1e-7
# Bounds of int T_k'(s)/sqrt(t - s) ds, -1 < s < t < 1, over k, and of the same integral of T_k''
# over k^3, found for k up to 24.
_LOAD_PER_DEGREE = 2.9
_STIFFNESS_PER_DEGREE_CUBED = 1.5
# Lower bound of P/(E* a) = int cos(angle) h'(a cos(angle)) d angle, over the largest h' below a: it
# is 0.59 for a slope x^3.
_LEAST_LOAD_PER_SLOPE = 0.5
# Round-off over h far below the extent, up to which h has all its digits at any x; and the end,
# over the extent, of the interval of x where that is looked at.
_LARGEST_ROUNDOFF_OF_EXACT_HEIGHT = 1e-15
_PLACE_SHARE_NEAR_ZERO = 2.0**-20
# The polynomial in x^2 may end at the extent over 2^0 to 2^13; its lowest powers of x^2.
_LARGEST_HALVING_OF_END = 13
_LOWEST_EXPONENTS = (1, 2, 3, 4)
# A fit that reaches farther out is preferred to one whose error is half as large.
_RATIO_OF_ALIKE_ERRORS = 2.0
# Round-off above the end of the polynomial in x^2 may be so many times that below.
_GROWTH_OF_ROUNDOFF = 10.0
# Error of a series that `fit` takes as resolved, over the scale it is given.
_RESOLUTION_OF_FIT = 4e-15


class LoadErrors(NamedTuple):
    """Largest relative errors that round-off in a profile's height h causes in its contact law.

    Attributes
    ----------
    load
        error of the load P = E* int x h'(x)/sqrt(a^2 - x^2) dx, over P
    stiffness
        error of dP/da, over P/a, with a the contact half-width
    """

    load: float
    stiffness: float

    def larger_of_each(self, errors: LoadErrors) -> LoadErrors:
        """The larger load error and the larger stiffness error of this one and another."""
        return LoadErrors(max(self.load, errors.load), max(self.stiffness, errors.stiffness))


@dataclass(frozen=True, eq=False)
class HeightSlope:
    """The slope h' of a profile's height over 0 < x <= extent.

    Attributes
    ----------
    slope
        h'(x), any shape
    interval_ends
        (n,) ascending; the slope is one polynomial on each interval between two of them
    load_errors
        errors of load and stiffness that round-off in the height causes
    """

    slope: Function
    interval_ends: Array
    load_errors: LoadErrors


def slope_of_height(height: Function, interval_ends: Array) -> HeightSlope:
    """Slope h' of a profile for x > 0, from a function that gives the height h only; and the errors
    of load and stiffness that round-off in the height causes.

    The height is approximated by Chebyshev series on intervals, which are differentiated. Near
    x = 0 a height such as R - sqrt(R^2 - x^2) has few correct digits. There one polynomial in x^2,
    fitted to many heights, takes the place of the series.

    Parameters
    ----------
    height
        h(x) [length], from an array of x to an array of heights
    interval_ends
        (n,) ascending x between which h is smooth: extent/2^k, and corners of the slope; the last
        is the extent, the largest x

    Raises
    ------
    UnresolvedError
        Where the height is too rough to have a slope.

    Examples
    --------
    >>> parabola = slope_of_height(lambda x: x**2 / 2, 2.0 ** np.arange(-3.0, 1.0))
    >>> parabola.slope(np.array([0.3, 0.9])).round(13).tolist(), parabola.load_errors.load < 1e-13
    ([0.3, 0.9], True)
    """
    extent = float(interval_ends[-1])
    height_at_middle = float(height(np.zeros(1)).item())

    def height_above_middle(x: Array) -> Array:
        """h(x) - h(0) at places x."""
        return height(x) - height_at_middle

    inner_polynomial = None
    # _LARGEST_ROUNDOFF_OF_EXACT_HEIGHT: 1e-15 of the height
    if (
        _relative_roundoff_near_zero(height_above_middle, extent)
        > _LARGEST_ROUNDOFF_OF_EXACT_HEIGHT
    ):
        # _LARGEST_HALVING_OF_END: 13; the polynomial ends at extent/2^13 or beyond
        possible_ends = interval_ends[interval_ends >= extent * 0.5**_LARGEST_HALVING_OF_END]
        inner_polynomial = _inner_polynomial(height_above_middle, possible_ends)
    if inner_polynomial is None:
        outer_interval_ends = interval_ends
        scale_of_fit = None
    elif inner_polynomial.end >= extent:
        return HeightSlope(inner_polynomial.slope, interval_ends, inner_polynomial.load_errors)
    else:
        outer_interval_ends = np.append(
            inner_polynomial.end, interval_ends[interval_ends > inner_polynomial.end]
        )
        # Outside too the height has round-off, which no series can resolve: it is to be ignored.
        # _GROWTH_OF_ROUNDOFF, _RESOLUTION_OF_FIT: 10 and 4e-15, of the scale that the fit is given
        scale_of_fit = _GROWTH_OF_ROUNDOFF * inner_polynomial.height_roundoff / _RESOLUTION_OF_FIT

    # Beyond the polynomial: series on intervals, and their derivatives.
    outer_series, outer_errors = _series_of_height(
        height_above_middle,
        piecewise_series_of(height_above_middle, outer_interval_ends, scale_of_fit).interval_ends,
    )
    outer_slope = outer_series.derivative
    all_interval_ends = np.union1d(interval_ends, outer_slope.interval_ends)
    if inner_polynomial is None:
        return HeightSlope(outer_slope, all_interval_ends, outer_errors)

    def slope(x: Array) -> Array:
        """h'(x): of the polynomial up to its end, of the series beyond."""
        return np.where(x < inner_polynomial.end, inner_polynomial.slope(x), outer_slope(x))

    load_errors = inner_polynomial.load_errors.larger_of_each(outer_errors)
    return HeightSlope(slope, all_interval_ends, load_errors)


@dataclass(frozen=True, eq=False)
class _Samples:
    """The n places on [-1, 1] at which a function is sampled for a least-squares Chebyshev series.

    Attributes
    ----------
    places
        (n,) Chebyshev points of 26 binary digits, so that low + half (1 + place) has next to no
        round-off
    polynomials
        (n, CHEBYSHEV_DEGREE + 1) Chebyshev polynomials T_k(place)
    coefficients_from_values
        matrix (n, CHEBYSHEV_DEGREE + 1); the row of n values times it, values @
        coefficients_from_values, is that of the least-squares coefficients
    """

    places: Array
    polynomials: Array
    coefficients_from_values: Array

    def series_and_roundoff(self, heights: Array) -> tuple[Array, Array]:
        """Chebyshev coefficients (..., CHEBYSHEV_DEGREE + 1) by least squares from heights (..., n)
        at n places on [-1, 1]; and the standard deviation (...,) of the heights' round-off, from
        the residuals.

        Heights times the matrix `coefficients_from_values` are coefficients, and `polynomials` of
        the same shape (n, CHEBYSHEV_DEGREE + 1) holds the Chebyshev polynomials at the places.
        """
        coefficients = heights @ self.coefficients_from_values
        # Once more for the residuals: sums of many values lose more digits than one value has lost.
        coefficients = (
            coefficients
            + (heights - coefficients @ self.polynomials.T) @ self.coefficients_from_values
        )
        residuals = heights - coefficients @ self.polynomials.T
        # Degrees of freedom of the residuals.
        n_degrees_of_freedom = len(self.places) - CHEBYSHEV_DEGREE - 1
        return coefficients, np.sqrt(np.sum(residuals * residuals, axis=-1) / n_degrees_of_freedom)

    @property
    def coefficient_roundoff_ratio(self) -> float:
        """Standard deviation of a coefficient's round-off over that of the sampled values."""
        return float((2 / len(self.places)) ** 0.5)

    def last_significant_degree(self, coefficients: Array, roundoff: Array) -> Array:
        """Degree (...,) of the last coefficient of each series that exceeds its round-off, taken as
        8 standard deviations; 1 at least.

        `coefficients` is (..., CHEBYSHEV_DEGREE + 1); `roundoff` (...,) is the standard deviation
        of the round-off of the values to which the series was fitted. That of a coefficient is
        smaller by `coefficient_roundoff_ratio`, sqrt(2/n) for n values.
        """
        # _DEVIATIONS_OF_SIGNIFICANT_TERM: 8 standard deviations
        is_significant = (
            np.abs(coefficients)
            > _DEVIATIONS_OF_SIGNIFICANT_TERM
            * self.coefficient_roundoff_ratio
            * roundoff[..., None]
        )
        return np.max(np.where(is_significant, np.arange(coefficients.shape[-1]), 1), axis=-1)


@cache
def _samples(n_samples: int) -> _Samples:
    """Chebyshev points, `n_samples` of them, with the matrices of the least-squares series."""
    odd_numbers = 2 * np.arange(n_samples - 1, -1, -1) + 1
    places = np.round(np.cos(odd_numbers * (np.pi / (2 * n_samples))) * 2.0**26) / 2.0**26
    polynomials = chebyshev.chebvander(places, CHEBYSHEV_DEGREE)
    return _Samples(places, polynomials, np.linalg.pinv(polynomials).T)


def _relative_roundoff_near_zero(height_above_middle: Function, extent: float) -> float:
    """Standard deviation of the round-off in a profile's height near x = 0, divided by the largest
    absolute height there: how many digits the height has.

    It is of heights h(x) - h(0) at 512 places x, from 2^-21 to 2^-20 of the `extent`, the largest
    x of the profile. Infinite where all these heights are 0, or where one is not finite.
    `height_above_middle` gives h(x) - h(0), from an array of x to an array of heights.
    """
    # Places on [-1, 1], and the least-squares series through values at them.
    # _SAMPLES_OF_INTERVAL: 512 places on [-1, 1]
    samples = _samples(_SAMPLES_OF_INTERVAL)
    # _PLACE_SHARE_NEAR_ZERO: 2^-20 of the extent
    heights = height_above_middle(extent * _PLACE_SHARE_NEAR_ZERO * (3 + samples.places) / 4)
    largest_height = float(np.max(np.abs(heights)))
    if not (largest_height > 0 and np.all(np.isfinite(heights))):
        return np.inf
    return float(samples.series_and_roundoff(heights)[1]) / largest_height


def _series_of_height(
    height_above_middle: Function, interval_ends: Array
) -> tuple[PiecewiseSeries, LoadErrors]:
    """Chebyshev series of a profile's height by least squares on intervals, and the errors of load
    and stiffness that round-off in the height causes.

    Coefficients that are mere round-off are set to 0.

    Parameters
    ----------
    height_above_middle
        h(x) - h(0) [length], from an array of x to an array of heights
    interval_ends
        (n + 1,) ascending x, the ends of the n intervals

    Raises
    ------
    UnresolvedError
        Where the height is too rough to have a slope.
    """
    # 512 places on [-1, 1] for each interval, and the least-squares series through values at them.
    samples = _samples(_SAMPLES_OF_INTERVAL)
    half_lengths = np.diff(interval_ends) / 2
    x = interval_ends[:-1, None] + half_lengths[:, None] * (1 + samples.places)
    # For each interval: coefficients, and standard deviation of the heights' round-off.
    # CHEBYSHEV_DEGREE: 24; `last_significant_degree`: of the last coefficient above its round-off
    coefficients, height_roundoff = samples.series_and_roundoff(height_above_middle(x))
    last_degree = samples.last_significant_degree(coefficients, height_roundoff)
    is_significant = np.arange(CHEBYSHEV_DEGREE + 1) <= last_degree[:, None]
    height_series = PiecewiseSeries(
        interval_ends, np.where(is_significant, coefficients, 0.0).T.copy()
    )

    # Four standard deviations of a coefficient's round-off are stated as its error.
    # `coefficient_roundoff_ratio`: round-off of a coefficient over that of a height
    coefficient_error = (
        _DEVIATIONS_IN_STATED_ERROR * samples.coefficient_roundoff_ratio * height_roundoff
    )
    return height_series, _errors_of_loads(height_series, is_significant, coefficient_error)


def _errors_of_loads(
    height_series: PiecewiseSeries, is_significant: Mask, coefficient_error: Array
) -> LoadErrors:
    """Largest relative errors of the load P(a) and of the stiffness dP/da that come from round-off
    in the coefficients of a height's Chebyshev series.

    Nearly P = E* sqrt(a/2) int h'(x)/sqrt(a - x) dx. The weight is largest at x = a, so only errors
    in the interval that ends at a are counted. A term c_k T_k of h adds c_k T_k' over half the
    interval's length to h'. The integral of that grows as k in P, and as k^3 in dP/da. Errors of
    coefficients are independent: their squares add.

    # notation: a contact half-width, E* contact modulus, h' slope of the height, T_k Chebyshev
    # polynomial

    Parameters
    ----------
    height_series
        Chebyshev series of the height on n intervals of x
    is_significant
        (n, CHEBYSHEV_DEGREE + 1) which coefficients are kept
    coefficient_error
        (n,) error of each coefficient on an interval [length]

    Raises
    ------
    UnresolvedError
        Where the load has a relative error above 1e-7.
    """
    interval_ends = height_series.interval_ends
    half_lengths = np.diff(interval_ends) / 2
    degree = np.arange(CHEBYSHEV_DEGREE + 1)
    # sqrt(a/2) over sqrt(half_length), with a at the end of each interval.
    half_width_factor = np.sqrt(interval_ends[1:] / (2 * half_lengths))
    scaled_coefficient_error = coefficient_error * half_width_factor
    # `_LOAD_PER_DEGREE` and `_STIFFNESS_PER_DEGREE_CUBED` bound the integrals of T_k' and T_k''.
    # Errors of P/E*, and of dP/da/E* times half_length.
    load_error = (
        scaled_coefficient_error
        * _LOAD_PER_DEGREE
        * np.sqrt(np.sum(is_significant * degree**2.0, axis=1))
    )
    stiffness_error = (
        scaled_coefficient_error
        * _STIFFNESS_PER_DEGREE_CUBED
        * np.sqrt(np.sum(is_significant * degree**6.0, axis=1))
    )
    largest_slope_up_to_end = _largest_slopes(height_series)
    has_slope = largest_slope_up_to_end > 0
    # Lower bound of P/(E* a).
    # _LEAST_LOAD_PER_SLOPE: 0.5, of the largest slope up to a
    least_load = _LEAST_LOAD_PER_SLOPE * largest_slope_up_to_end[has_slope]
    relative_load_error = load_error[has_slope] / interval_ends[1:][has_slope] / least_load

    # _LARGEST_RELATIVE_LOAD_ERROR: 1e-7 of the load
    rough_intervals = np.flatnonzero(relative_load_error > _LARGEST_RELATIVE_LOAD_ERROR)
    if len(rough_intervals):
        first_rough_interval = int(np.flatnonzero(has_slope)[rough_intervals[0]])
        raise UnresolvedError(
            float(interval_ends[first_rough_interval]),
            float(interval_ends[first_rough_interval + 1]),
        )
    relative_stiffness_error = stiffness_error[has_slope] / half_lengths[has_slope] / least_load
    return LoadErrors(
        float(np.max(relative_load_error, initial=0.0)),
        float(np.max(relative_stiffness_error, initial=0.0)),
    )


def _largest_slopes(height_series: PiecewiseSeries) -> Array:
    """Largest slope |h'| of a height up to the end of each of n intervals, (n,): of nine places on
    that interval and on each one before.
    """
    interval_ends = height_series.interval_ends
    half_lengths = np.diff(interval_ends) / 2
    x = interval_ends[:-1, None] + half_lengths[:, None] * np.linspace(0, 2, 9)
    largest_slope_in_interval = np.max(np.abs(height_series.derivative(x)), axis=1)
    return np.asarray(np.maximum.accumulate(largest_slope_in_interval))


@dataclass(frozen=True, eq=False)
class _InnerPolynomial:
    """A height near x = 0 as one polynomial in x^2: h = s^m g(s) with s = (x/end)^2 for x <= `end`,
    so that h' = (2 x/end^2) s^(m - 1) [m g + s g'].

    Attributes
    ----------
    end
        largest x of the fit [length]
    slope_series
        m g + s g' as a Chebyshev series on 0 < s < 1 [length]
    exponent
        m - 1, of the power of s in front of it
    height_roundoff
        standard deviation of the heights' round-off [length]
    load_errors
        errors of load and stiffness that this causes
    """

    end: float
    slope_series: chebyshev.Chebyshev
    exponent: int
    height_roundoff: float
    load_errors: LoadErrors

    def slope(self, x: Array) -> Array:
        """h'(x), any shape."""
        s = np.square(x / self.end)
        return np.asarray(2 * x / self.end**2 * s**self.exponent * self.slope_series(s))


def _inner_polynomial(
    height_above_middle: Function, possible_ends: Array
) -> _InnerPolynomial | None:
    """Polynomial in x^2 that a profile's height follows from x = 0 to one of `possible_ends` (n,);
    None where no such polynomial follows it.

    Of the ends whose load error is within a factor of two of the least, the largest is taken.
    `height_above_middle` is h(x) - h(0), from an array of x to an array of heights. A polynomial
    holds its `end`, and in `load_errors` the relative errors of load and stiffness by round-off.
    """
    # A fit to 512 heights up to each end, the largest first; None where none follows the height.
    fits = [
        _polynomial_up_to(end, height_above_middle, _SAMPLES_OF_INTERVAL)
        for end in possible_ends[::-1].tolist()
    ]
    polynomials = [polynomial for polynomial in fits if polynomial is not None]
    if not polynomials:
        return None
    least_load_error = min(polynomial.load_errors.load for polynomial in polynomials)
    # _RATIO_OF_ALIKE_ERRORS: 2, of load errors
    widest_polynomial = next(
        polynomial
        for polynomial in polynomials
        if polynomial.load_errors.load <= _RATIO_OF_ALIKE_ERRORS * least_load_error
    )

    # Fitted again to 4,096 heights, which leaves less round-off.
    refitted_polynomial = _polynomial_up_to(
        widest_polynomial.end, height_above_middle, _SAMPLES_OF_POLYNOMIAL
    )
    return refitted_polynomial or widest_polynomial


def _polynomial_up_to(
    end: float, height_above_middle: Function, n_samples: int
) -> _InnerPolynomial | None:
    """Polynomial in x^2 fitted to a profile's height for 0 <= x <= `end`, at `n_samples` places;
    None where the height does not follow it, or has too much round-off for a slope.

    Its lowest power of x^2 has the first exponent, from 1 up to 4, whose slope has an error below
    1e-7: a height that rises as x^4 has no term x^2. `height_above_middle` is h(x) - h(0), from an
    array of x to an array of heights.
    """
    # Places on [-1, 1], that is 2 (x/end)^2 - 1.
    samples = _samples(n_samples)
    heights = height_above_middle(end * np.sqrt((1 + samples.places) / 2))
    if not np.all(np.isfinite(heights)):
        return None
    # Chebyshev coefficients of the height over 2 (x/end)^2 - 1, and standard deviation of its
    # round-off.
    coefficients, roundoff_of_heights = samples.series_and_roundoff(heights)
    height_roundoff = float(roundoff_of_heights)
    # The last coefficients must be explained by round-off: else the series is cut off too early.
    # _DEVIATIONS_OF_EXPLAINED_TERM: 6 standard deviations of a coefficient's round-off
    # `coefficient_roundoff_ratio`: round-off of a coefficient over that of a height
    explained_size = (
        _DEVIATIONS_OF_EXPLAINED_TERM * samples.coefficient_roundoff_ratio * height_roundoff
    )
    if float(truncation_error(coefficients)) > explained_size:
        return None

    # Degree of the last coefficient that exceeds its round-off.
    last_degree = int(samples.last_significant_degree(coefficients, roundoff_of_heights))
    # _LOWEST_EXPONENTS: 1 to 4, of x^2
    for lowest_exponent in _LOWEST_EXPONENTS:
        # Without the first powers the same degree takes fewer coefficients.
        n_coefficients = max(last_degree - lowest_exponent, 0) + 1
        polynomial = _polynomial_of_lowest_exponent(
            samples, heights, end, lowest_exponent, n_coefficients, height_roundoff
        )
        if polynomial is not None:
            return polynomial
    return None


def _polynomial_of_lowest_exponent(
    samples: _Samples,
    heights: Array,
    largest_x: float,
    lowest_exponent: int,
    n_coefficients: int,
    height_roundoff: float,
) -> _InnerPolynomial | None:
    """Least-squares fit of a profile's heights near x = 0 by a polynomial in x^2 that begins with a
    given power; and the errors of load and stiffness by round-off in the heights.

    With s = (x/X)^2, X = `largest_x`, the fit is h = s^m g(s). Its slope is
    h' = (2 x/X^2) s^(m-1) B(s), where B = m g + s g'. The load is an integral of h', so its
    relative error is in proportion to that of B. The errors are taken at both ends of the fit,
    s = 0 and s = 1. None where four standard deviations of round-off make an error of B above 1e-7
    of B there.

    Parameters
    ----------
    samples
        n places on [-1, 1], that is 2 s - 1, and Chebyshev polynomials there
    heights
        (n,) h - h(0) at the places [length]
    largest_x
        X, at which the fit ends [length]
    lowest_exponent
        m, the exponent of the lowest power of x^2
    n_coefficients
        number of Chebyshev coefficients of g
    height_roundoff
        standard deviation of the heights' round-off [length]
    """
    s = (1 + samples.places) / 2
    # `inverse_of_triangle` (k, k): a sum c . g_coefficients has a round-off of norm(c @ inverse)
    # standard deviations of a height.
    g_coefficients, inverse_of_triangle = _refined_least_squares(
        s[:, None] ** lowest_exponent * samples.polynomials[:, :n_coefficients], heights
    )
    # B of each Chebyshev polynomial of g, as a series in s.
    terms_of_b = _slope_terms(lowest_exponent, n_coefficients)
    # B and its derivative dB/ds at s = 0 and s = 1 are linear in g: a column for each coefficient.
    s_of_ends = np.array([0.0, 1.0])
    b_at_ends = np.stack([term(s_of_ends) for term in terms_of_b], axis=1)
    b_rate_at_ends = np.stack([term.deriv()(s_of_ends) for term in terms_of_b], axis=1)

    # Errors of B and dB/ds at the ends: four standard deviations (_DEVIATIONS_IN_STATED_ERROR).
    stated_roundoff = _DEVIATIONS_IN_STATED_ERROR * height_roundoff
    b_errors = stated_roundoff * np.linalg.norm(b_at_ends @ inverse_of_triangle, axis=1)
    b_rate_errors = stated_roundoff * np.linalg.norm(b_rate_at_ends @ inverse_of_triangle, axis=1)
    b_sizes = np.abs(b_at_ends @ g_coefficients)
    # _LARGEST_RELATIVE_LOAD_ERROR: 1e-7 of the load
    if not np.all(b_errors < _LARGEST_RELATIVE_LOAD_ERROR * b_sizes):
        return None

    # B as a series, and the errors of load and stiffness.
    b_series = sum(
        coefficient * term
        for coefficient, term in zip(g_coefficients.tolist(), terms_of_b, strict=True)
    )
    # _LEAST_LOAD_PER_SLOPE: 0.5, the least P/(E* a) over the largest slope
    load_error = float(np.max(b_errors / b_sizes)) / _LEAST_LOAD_PER_SLOPE
    # a dP/da is P and an integral of x h'', which is (2 m - 1) h' + (2 x/X^2) s^(m-1) 2 s dB/ds.
    error_by_b_rate = float(np.max(2 * s_of_ends * b_rate_errors / b_sizes)) / _LEAST_LOAD_PER_SLOPE
    stiffness_error = 2 * lowest_exponent * load_error + error_by_b_rate
    return _InnerPolynomial(
        largest_x,
        b_series,
        lowest_exponent - 1,
        height_roundoff,
        LoadErrors(load_error, stiffness_error),
    )


def _refined_least_squares(equations: Array, right_side: Array) -> tuple[Array, Array]:
    """Least-squares solution (k,) of n equations (n, k) for the right side (n,), and the inverse
    (k, k) of the triangle R of the factorisation Q R of the equations.

    The inverse gives the error of the solution: where the n entries of the right side have
    independent errors of standard deviation e, entry j of the solution has one of e times the norm
    of row j. The residuals are solved for once more: a single solution leaves them too large by
    round-off.
    """
    orthogonal_factor, triangular_factor = np.linalg.qr(equations)
    inverse_of_triangle = np.linalg.inv(triangular_factor)
    solution = inverse_of_triangle @ (orthogonal_factor.T @ right_side)
    residuals = right_side - (orthogonal_factor @ (triangular_factor @ solution))
    solution = solution + inverse_of_triangle @ (orthogonal_factor.T @ residuals)
    return solution, inverse_of_triangle


def _slope_terms(lowest_exponent: int, n_coefficients: int) -> list[chebyshev.Chebyshev]:
    """The terms m T_j + s T_j' of B = m g + s g', one for each Chebyshev polynomial T_j(s) of g on
    0 <= s <= 1: the slope of a profile h = s^m g(s) is a multiple of B. m is `lowest_exponent`.
    """
    s_series = chebyshev.Chebyshev([0.5, 0.5], domain=[0.0, 1.0])
    polynomials = [chebyshev.Chebyshev(row, domain=[0.0, 1.0]) for row in np.eye(n_coefficients)]
    return [
        lowest_exponent * polynomial + s_series * polynomial.deriv() for polynomial in polynomials
    ]
