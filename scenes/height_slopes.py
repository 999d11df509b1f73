"""Slope h' of a height h that a function gives, and what the rounding of its values leaves
uncertain in loads.

A derivative of a series multiplies the rounding in coefficient k by k^2. So each series is fitted
by least squares to many more values than it has coefficients, and coefficients within the rounding
are dropped. The rounding of the values is what a series of full degree leaves of them; a
coefficient of n values has sqrt(2/n) of it.

Near x = 0 a height such as R - sqrt(R^2 - x^2) is a difference of larger numbers. There it has few
digits of its own, and the slope is that of one polynomial of x^2 which begins at 0, fitted as far
out as one resolves h.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from scenes.array_types import Array, Mask
from scenes.chebyshev import DEGREE, Pieces, Unresolved, fit, tail

Function = Callable[[Array], Array]

# Values that a series is fitted to: of a piece, and of the polynomial of x^2. The rounding of one
# is left by 6 % and by 2 %.
_SAMPLES_OF_PIECE = 512
_SAMPLES_OF_CORE = 4096
# A coefficient counts from so many standard deviations on. Rounding is no perfect chance: above 4
# some is left, above 8 none was seen; what is dropped with it costs 1e-15 of a load.
_SIGNIFICANT_DEVIATIONS = 8.0
# So many standard deviations are stated as error.
_STATED_DEVIATIONS = 4.0
# Where rounding explains the last coefficients they are no more than so many standard deviations.
_EXPLAINED_DEVIATIONS = 6.0
# Largest error of a load, over the load: beyond, a height is too rough to have a slope.
_LARGEST_LOAD_ERROR = 1e-7
# Bounds of int T_k'(s)/sqrt(t - s) ds, -1 < s < t < 1, over k, and of the same integral of T_k''
# over k^3, found for k up to 24.
_FACTOR_OF_LOAD = 2.9
_FACTOR_OF_STIFFNESS = 1.5
# int cos(angle) h'(a cos(angle)) d angle over the largest h' below a: 0.59 of a slope x^3.
_LEAST_LOAD = 0.5
# Rounding of an octave far down, over h there, up to which h has its digits at any x; where the
# octave ends, over the extent.
_EXACT_ROUNDING = 1e-15
_FAR_OCTAVE = 2.0**-20
# Octaves below the extent in which the polynomial of x^2 may end, and its lowest powers of x^2.
_OCTAVES_OF_ENDS = 13
_LOWEST_POWERS = (1, 2, 3, 4)
# A fit that reaches farther out is preferred to one whose error is half as large.
_ALIKE_RATIO = 2.0
# Rounding above the end of the polynomial of x^2 may be so many times that below.
_GROWTH_OF_ROUNDING = 10.0


class Rounding(NamedTuple):
    """What the rounding of h leaves uncertain, at most.

    Attributes
    ----------
    load
        of P = E* int x h'(x)/sqrt(a^2 - x^2) dx, over P
    stiffness
        of dP/da, over P/a
    """

    load: float
    stiffness: float

    def or_more(self, rounding: Rounding) -> Rounding:
        """The larger of two of each."""
        return Rounding(max(self.load, rounding.load), max(self.stiffness, rounding.stiffness))


@dataclass(frozen=True, eq=False)
class HeightSlope:
    """The slope of a height over 0 < x <= extent.

    Attributes
    ----------
    slope
        h'(x), any shape
    edges
        (n,) ends of the pieces on which the slope is one polynomial
    rounding
        what it leaves uncertain in loads
    """

    slope: Function
    edges: Array
    rounding: Rounding


def slope_of_height(height: Function, edges: Array) -> HeightSlope:
    """Derivative h' of a profile's height for x > 0, given only as a function, with the error that
    round-off of its values causes in loads.

    The height is approximated by Chebyshev series on intervals, which are differentiated. Where it
    has few digits near x = 0, as R - sqrt(R^2 - x^2) has, one polynomial in x^2 takes their place.

    Parameters
    ----------
    height
        h(x), from an array of places to one of values
    edges
        (n,) ascending places between which h is smooth: octaves below the largest x, and corners

    Raises
    ------
    Unresolved
        Where the height is too rough to have a slope.

    Examples
    --------
    >>> found = slope_of_height(lambda x: x**2 / 2, 2.0 ** np.arange(-3.0, 1.0))
    >>> found.slope(np.array([0.3, 0.9])).round(13).tolist(), found.rounding.load < 1e-13
    ([0.3, 0.9], True)
    """
    extent = float(edges[-1])
    middle_height = float(height(np.zeros(1)).item())

    def height_above_middle(x: Array) -> Array:
        return height(x) - middle_height

    core = None
    if _rounding_far_down(height_above_middle, extent) > _EXACT_ROUNDING:
        core = _core(height_above_middle, edges[edges >= extent * 0.5**_OCTAVES_OF_ENDS])
    if core is not None and core.end >= extent:
        return HeightSlope(core.slope, edges, core.rounding)
    upper_edges = edges if core is None else np.append(core.end, edges[edges > core.end])
    # `fit` resolves to 4e-15 of a scale.
    scale = None if core is None else _GROWTH_OF_ROUNDING * core.of_heights / 4e-15
    pieces, rounding_above = _refined(
        height_above_middle, fit(height_above_middle, upper_edges, scale).edges
    )
    slope_above = pieces.derivative
    all_edges = np.union1d(edges, slope_above.edges)
    if core is None:
        return HeightSlope(slope_above, all_edges, rounding_above)

    def slope(x: Array) -> Array:
        return np.where(x < core.end, core.slope(x), slope_above(x))

    return HeightSlope(slope, all_edges, core.rounding.or_more(rounding_above))


@dataclass(frozen=True, eq=False)
class _Samples:
    """Places on [-1, 1] and T_k there.

    Attributes
    ----------
    places
        (n,) Chebyshev points of 26 binary digits, so that low + half (1 + place) has next to no
        rounding
    values
        (n, DEGREE + 1) T_k(place)
    to_series
        (n, DEGREE + 1) coefficients by least squares are values at the places times this
    """

    places: Array
    values: Array
    to_series: Array

    def series_and_rounding(self, heights: Array) -> tuple[Array, Array]:
        """Chebyshev coefficients (..., DEGREE + 1) by least squares from heights (..., n) at many
        places, and the standard deviation of the heights' round-off, (...,), by the residuals.
        """
        coefficients = heights @ self.to_series
        # Once more for the residuals: sums of many values lose more digits than one value has lost.
        coefficients = coefficients + (heights - coefficients @ self.values.T) @ self.to_series
        residuals = heights - coefficients @ self.values.T
        n_free = len(self.places) - DEGREE - 1
        return coefficients, np.sqrt(np.sum(residuals * residuals, axis=-1) / n_free)

    @property
    def of_coefficient(self) -> float:
        """What rounding leaves in a coefficient, over the rounding of the values."""
        return float((2 / len(self.places)) ** 0.5)

    def last_of(self, coefficients: Array, rounding: Array) -> Array:
        """Number of the last coefficient that is no rounding, (...,); 1 at least."""
        counts = (
            np.abs(coefficients)
            > _SIGNIFICANT_DEVIATIONS * self.of_coefficient * rounding[..., None]
        )
        return np.max(np.where(counts, np.arange(coefficients.shape[-1]), 1), axis=-1)


@cache
def _samples(count: int) -> _Samples:
    odd_numbers = 2 * np.arange(count - 1, -1, -1) + 1
    places = np.round(np.cos(odd_numbers * (np.pi / (2 * count))) * 2.0**26) / 2.0**26
    values = chebyshev.chebvander(places, DEGREE)
    return _Samples(places, values, np.linalg.pinv(values).T)


def _rounding_far_down(rise: Function, extent: float) -> float:
    """Relative round-off of a profile's height in one octave of x far below its `extent`, as a
    measure of how many digits the height has near x = 0; infinite where it is 0 or no number.
    """
    samples = _samples(_SAMPLES_OF_PIECE)
    heights = rise(extent * _FAR_OCTAVE * (3 + samples.places) / 4)
    largest_height = float(np.max(np.abs(heights)))
    if not (largest_height > 0 and np.all(np.isfinite(heights))):
        return np.inf
    return float(samples.series_and_rounding(heights)[1]) / largest_height


def _refined(rise: Function, edges: Array) -> tuple[Pieces, Rounding]:
    """Chebyshev series of a profile's height by least squares on intervals, without coefficients
    that are mere round-off, and the error that round-off leaves in loads and stiffness.

    Parameters
    ----------
    rise
        height above the middle, from an array of x to one of values
    edges
        (n,) ends of the intervals

    Raises
    ------
    Unresolved
        Where the height is too rough to have a slope.
    """
    samples = _samples(_SAMPLES_OF_PIECE)
    half_lengths = np.diff(edges) / 2
    coefficients, rounding = samples.series_and_rounding(
        rise(edges[:-1, None] + half_lengths[:, None] * (1 + samples.places))
    )
    last_significant = samples.last_of(coefficients, rounding)
    is_significant = np.arange(DEGREE + 1) <= last_significant[:, None]
    pieces = Pieces(edges, np.where(is_significant, coefficients, 0.0).T.copy())
    coefficient_error = _STATED_DEVIATIONS * samples.of_coefficient * rounding
    return pieces, _errors_of_loads(pieces, is_significant, coefficient_error)


def _errors_of_loads(pieces: Pieces, is_significant: Mask, coefficient_error: Array) -> Rounding:
    """Largest relative errors of the load P and of the stiffness dP/da that come from round-off in
    the coefficients of a height's Chebyshev series.

    Nearly P = E* sqrt(a/2) int h'(x)/sqrt(a - x) dx, so the interval in which a lies counts most.
    A term c_k T_k of h adds c_k T_k' over half the interval's length to h'. The integral of that
    grows as k in P, and as k^3 in dP/da. Errors of coefficients are independent: squares add.

    # notation: a contact half-width, E* contact modulus, h' slope of the height, T_k Chebyshev
    # polynomial

    Parameters
    ----------
    pieces
        series of the height on n intervals
    is_significant
        (n, DEGREE + 1) which coefficients are kept
    coefficient_error
        (n,) error of each coefficient on an interval

    Raises
    ------
    Unresolved
        Where the load has a relative error above 1e-7.
    """
    edges = pieces.edges
    half_lengths = np.diff(edges) / 2
    number = np.arange(DEGREE + 1)
    root_of_end = np.sqrt(edges[1:] / (2 * half_lengths))
    deviation = coefficient_error * root_of_end
    load_error = deviation * _FACTOR_OF_LOAD * np.sqrt(np.sum(is_significant * number**2.0, axis=1))
    stiffness_error = (
        deviation * _FACTOR_OF_STIFFNESS * np.sqrt(np.sum(is_significant * number**6.0, axis=1))
    )
    places = edges[:-1, None] + half_lengths[:, None] * np.linspace(0, 2, 9)
    steepest = np.maximum.accumulate(np.max(np.abs(pieces.derivative(places)), axis=1))
    has_slope = steepest > 0
    least_load = _LEAST_LOAD * steepest[has_slope]
    relative_load_error = load_error[has_slope] / edges[1:][has_slope] / least_load
    rough_pieces = np.flatnonzero(relative_load_error > _LARGEST_LOAD_ERROR)
    if len(rough_pieces):
        piece = int(np.flatnonzero(has_slope)[rough_pieces[0]])
        raise Unresolved(float(edges[piece]), float(edges[piece + 1]))
    relative_stiffness_error = stiffness_error[has_slope] / half_lengths[has_slope] / least_load
    return Rounding(
        float(np.max(relative_load_error, initial=0.0)),
        float(np.max(relative_stiffness_error, initial=0.0)),
    )


@dataclass(frozen=True, eq=False)
class _Core:
    """The slope of h = s^m g(s), s = (x/end)^2, for x <= `end`: h' = (2 x/end^2) s^(m - 1) [m g + s
    g'].

    Attributes
    ----------
    bracket, power
        m g + s g' as a series on 0 < s < 1; m - 1
    of_heights
        rounding of the values of h
    rounding
        what it leaves uncertain in loads
    """

    end: float
    bracket: chebyshev.Chebyshev
    power: int
    of_heights: float
    rounding: Rounding

    def slope(self, x: Array) -> Array:
        """h'(x), any shape."""
        s = np.square(x / self.end)
        return np.asarray(2 * x / self.end**2 * s**self.power * self.bracket(s))


def _core(rise: Function, ends: Array) -> _Core | None:
    """Slope of a profile's height near x = 0 by one polynomial in x^2, from 0 to one of several
    `ends`; None where no such polynomial follows the height.

    Of the ends whose error in loads is within a factor of two of the least, the largest is taken.
    `rise` is the height above the middle, as a function of x.
    """
    candidates = [_core_up_to(rise, end, _SAMPLES_OF_PIECE) for end in ends[::-1].tolist()]
    cores = [core for core in candidates if core is not None]
    if not cores:
        return None
    least_load_error = min(core.rounding.load for core in cores)
    widest_core = next(
        core for core in cores if core.rounding.load <= _ALIKE_RATIO * least_load_error
    )
    return _core_up_to(rise, widest_core.end, _SAMPLES_OF_CORE) or widest_core


def _core_up_to(rise: Function, end: float, count: int) -> _Core | None:
    """Slope of a profile's height for 0 <= x <= `end` by one polynomial in x^2, fitted to `count`
    of its values; None where it does not follow the height, or round-off leaves no slope.

    Its lowest power of x^2 is tried from 1 up: a height that rises as x^4 has no x^2. `rise` is the
    height above the middle, as a function of x.
    """
    samples = _samples(count)
    heights = rise(end * np.sqrt((1 + samples.places) / 2))
    if not np.all(np.isfinite(heights)):
        return None
    coefficients, height_rounding = samples.series_and_rounding(heights)
    rounding_of_heights = float(height_rounding)
    if (
        float(tail(coefficients))
        > _EXPLAINED_DEVIATIONS * samples.of_coefficient * rounding_of_heights
    ):
        return None
    last_power = int(samples.last_of(coefficients, height_rounding))
    for power in _LOWEST_POWERS:
        core = _with_lowest_power(
            samples, heights, end, power, max(last_power - power, 0) + 1, rounding_of_heights
        )
        if core is not None:
            return core
    return None


def _with_lowest_power(
    samples: _Samples, heights: Array, end: float, power: int, count: int, rounding: float
) -> _Core | None:
    """Fit heights near x = 0 by h = s^m g(s) with s = (x/end)^2, and estimate the error that
    round-off leaves in loads and stiffness; None where it leaves no slope at s = 0 or s = 1.

    With h' = (2 x/end^2) s^(m-1) [m g + s g'] the errors of the bracket, and of its derivative, at
    s = 0 and s = 1 give those of loads and stiffness.

    Parameters
    ----------
    samples
        places of the heights, and Chebyshev polynomials there
    heights
        (n,) above the middle
    end
        largest x of the fit
    power
        m, the lowest power of x^2
    count
        number of coefficients of the series g
    rounding
        standard deviation of the heights' round-off
    """
    s = (1 + samples.places) / 2
    orthogonal_factor, triangular_factor = np.linalg.qr(
        s[:, None] ** power * samples.values[:, :count]
    )
    inverse_of_triangle = np.linalg.inv(triangular_factor)
    g = inverse_of_triangle @ (orthogonal_factor.T @ heights)
    g = g + inverse_of_triangle @ (
        orthogonal_factor.T @ (heights - (orthogonal_factor @ (triangular_factor @ g)))
    )

    # The bracket and its derivative by s at s = 0 and s = 1 are linear in g.
    coordinate = chebyshev.Chebyshev([0.5, 0.5], domain=[0.0, 1.0])
    terms = [chebyshev.Chebyshev(row, domain=[0.0, 1.0]) for row in np.eye(count)]
    brackets = [power * term + coordinate * term.deriv() for term in terms]
    ends = np.array([0.0, 1.0])
    bracket_values = np.stack([bracket(ends) for bracket in brackets], axis=1)
    bracket_rates = np.stack([bracket.deriv()(ends) for bracket in brackets], axis=1)
    stated_rounding = _STATED_DEVIATIONS * rounding
    value_errors = stated_rounding * np.linalg.norm(bracket_values @ inverse_of_triangle, axis=1)
    rate_errors = stated_rounding * np.linalg.norm(bracket_rates @ inverse_of_triangle, axis=1)
    bracket_sizes = np.abs(bracket_values @ g)
    if not np.all(value_errors < _LARGEST_LOAD_ERROR * bracket_sizes):
        return None
    bracket = sum(
        coefficient * bracket_of_term
        for coefficient, bracket_of_term in zip(g.tolist(), brackets, strict=True)
    )
    load_error = float(np.max(value_errors / bracket_sizes)) / _LEAST_LOAD
    # dP/da is of x h'' too: (2 m - 1) h' + 2 s times the rate of the bracket.
    stiffness_error = (
        2 * power * load_error + float(np.max(2 * ends * rate_errors / bracket_sizes)) / _LEAST_LOAD
    )
    return _Core(end, bracket, power - 1, rounding, Rounding(load_error, stiffness_error))
