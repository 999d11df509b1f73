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

from scenes.array_types import Array
from scenes.chebyshev import DEGREE, Pieces, Unresolved, fit, tail

Function = Callable[[Array], Array]

# Values that a series is fitted to: of a piece, and of the polynomial of x^2. The rounding of one
# is left by 6 % and by 2 %.
_OF_PIECE = 512
_OF_CORE = 4096
# A coefficient counts from so many standard deviations on. Rounding is no perfect chance: above 4
# some is left, above 8 none was seen; what is dropped with it costs 1e-15 of a load.
_SIGNIFICANT = 8.0
# So many standard deviations are stated as error.
_STATED = 4.0
# Where rounding explains the last coefficients they are no more than so many standard deviations.
_EXPLAINED = 6.0
# Largest error of a load, over the load: beyond, a height is too rough to have a slope.
_ROUGHEST = 1e-7
# Bounds of int T_k'(s)/sqrt(t - s) ds, -1 < s < t < 1, over k, and of the same integral of T_k''
# over k^3, found for k up to 24.
_OF_LOAD = 2.9
_OF_STIFFNESS = 1.5
# int cos(angle) h'(a cos(angle)) d angle over the largest h' below a: 0.59 of a slope x^3.
_LEAST_LOAD = 0.5
# Rounding of an octave far down, over h there, up to which h has its digits at any x; where the
# octave ends, over the extent.
_EXACT = 1e-15
_FAR_DOWN = 2.0**-20
# Octaves below the extent in which the polynomial of x^2 may end, and its lowest powers of x^2.
_ENDS = 13
_LOWEST = (1, 2, 3, 4)
# A fit that reaches farther out is preferred to one whose error is half as large.
_ALIKE = 2.0
# Rounding above the end of the polynomial of x^2 may be so many times that below.
_GROWS = 10.0


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
    """The slope of `height` between `edges` (n,), ascending: octaves below the extent, and corners.

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
    at_middle = float(height(np.zeros(1)).item())

    def rise(x: Array) -> Array:
        return height(x) - at_middle

    core = None
    if _rounding_far_down(rise, extent) > _EXACT:
        core = _core(rise, edges[edges >= extent * 0.5**_ENDS])
    if core is not None and core.end >= extent:
        return HeightSlope(core.slope, edges, core.rounding)
    upper_edges = edges if core is None else np.append(core.end, edges[edges > core.end])
    # `fit` resolves to 4e-15 of a scale.
    scale = None if core is None else _GROWS * core.of_heights / 4e-15
    pieces, rounding = _refined(rise, fit(rise, upper_edges, scale).edges)
    slope_above = pieces.derivative
    all_edges = np.union1d(edges, slope_above.edges)
    if core is None:
        return HeightSlope(slope_above, all_edges, rounding)

    def slope(x: Array) -> Array:
        return np.where(x < core.end, core.slope(x), slope_above(x))

    return HeightSlope(slope, all_edges, core.rounding.or_more(rounding))


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
        """Coefficients (..., DEGREE + 1) from values at `places` on the last axis, and the rounding
        of the values (...,).
        """
        coefficients = heights @ self.to_series
        # A second time of what is left: sums of many values lose more than the rounding of one.
        coefficients = coefficients + (heights - coefficients @ self.values.T) @ self.to_series
        left = heights - coefficients @ self.values.T
        return coefficients, np.sqrt(np.sum(left * left, axis=-1) / (len(self.places) - DEGREE - 1))

    @property
    def of_coefficient(self) -> float:
        """What rounding leaves in a coefficient, over the rounding of the values."""
        return float((2 / len(self.places)) ** 0.5)

    def last_of(self, coefficients: Array, rounding: Array) -> Array:
        """Number of the last coefficient that is no rounding, (...,); 1 at least."""
        counts = np.abs(coefficients) > _SIGNIFICANT * self.of_coefficient * rounding[..., None]
        return np.max(np.where(counts, np.arange(coefficients.shape[-1]), 1), axis=-1)


@cache
def _samples(count: int) -> _Samples:
    odd_numbers = 2 * np.arange(count - 1, -1, -1) + 1
    places = np.round(np.cos(odd_numbers * (np.pi / (2 * count))) * 2.0**26) / 2.0**26
    values = chebyshev.chebvander(places, DEGREE)
    return _Samples(places, values, np.linalg.pinv(values).T)


def _rounding_far_down(rise: Function, extent: float) -> float:
    """Rounding of h over h in one octave far below the extent; infinite where h is 0 or no
    number.
    """
    samples = _samples(_OF_PIECE)
    heights = rise(extent * _FAR_DOWN * (3 + samples.places) / 4)
    largest_height = float(np.max(np.abs(heights)))
    if not (largest_height > 0 and np.all(np.isfinite(heights))):
        return np.inf
    return float(samples.series_and_rounding(heights)[1]) / largest_height


def _refined(rise: Function, edges: Array) -> tuple[Pieces, Rounding]:
    """Series of h between `edges`, and what its rounding leaves uncertain."""
    samples = _samples(_OF_PIECE)
    low = edges[:-1]
    half_length = np.diff(edges) / 2
    coefficients, rounding = samples.series_and_rounding(
        rise(low[:, None] + half_length[:, None] * (1 + samples.places))
    )
    number = np.arange(DEGREE + 1)
    is_significant = number <= samples.last_of(coefficients, rounding)[:, None]
    pieces = Pieces(edges, np.where(is_significant, coefficients, 0.0).T.copy())

    # P = E* sqrt(a/2) int h'(x)/sqrt(a - x) dx, nearly, and h' = T_k'/half: the piece that a is on
    # counts most.
    deviation = _STATED * samples.of_coefficient * rounding * np.sqrt(edges[1:] / (2 * half_length))
    of_load = deviation * _OF_LOAD * np.sqrt(np.sum(is_significant * number**2.0, axis=1))
    of_stiffness = deviation * _OF_STIFFNESS * np.sqrt(np.sum(is_significant * number**6.0, axis=1))
    places = low[:, None] + half_length[:, None] * np.linspace(0, 2, 9)
    steepest = np.maximum.accumulate(np.max(np.abs(pieces.derivative(places)), axis=1))
    rises = steepest > 0
    loads = _LEAST_LOAD * steepest[rises]
    load_errors = of_load[rises] / edges[1:][rises] / loads
    rough_pieces = np.flatnonzero(load_errors > _ROUGHEST)
    if len(rough_pieces):
        piece = int(np.flatnonzero(rises)[rough_pieces[0]])
        raise Unresolved(float(edges[piece]), float(edges[piece + 1]))
    stiffness_errors = of_stiffness[rises] / half_length[rises] / loads
    return pieces, Rounding(
        float(np.max(load_errors, initial=0.0)), float(np.max(stiffness_errors, initial=0.0))
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
    """The polynomial of x^2 with the least error, or nearly so, and of those the widest; None where
    no end resolves h.
    """
    candidates = [_core_up_to(rise, end, _OF_PIECE) for end in ends[::-1].tolist()]
    cores = [core for core in candidates if core is not None]
    if not cores:
        return None
    least_error = min(core.rounding.load for core in cores)
    widest = next(core for core in cores if core.rounding.load <= _ALIKE * least_error)
    return _core_up_to(rise, widest.end, _OF_CORE) or widest


def _core_up_to(rise: Function, end: float, count: int) -> _Core | None:
    """The same up to one end by `count` values; None where a series of x^2 does not resolve h, or
    rounding leaves no slope.
    """
    samples = _samples(count)
    heights = rise(end * np.sqrt((1 + samples.places) / 2))
    if not np.all(np.isfinite(heights)):
        return None
    coefficients, of_heights = samples.series_and_rounding(heights)
    rounding = float(of_heights)
    if float(tail(coefficients)) > _EXPLAINED * samples.of_coefficient * rounding:
        return None
    last_power = int(samples.last_of(coefficients, of_heights))
    for power in _LOWEST:
        core = _with_lowest_power(
            samples, heights, end, power, max(last_power - power, 0) + 1, rounding
        )
        if core is not None:
            return core
    return None


def _with_lowest_power(
    samples: _Samples, heights: Array, end: float, power: int, count: int, rounding: float
) -> _Core | None:
    """H = s^power g(s), g of `count` coefficients, by least squares; None where g(0) is
    rounding.
    """
    s = (1 + samples.places) / 2
    orthogonal, triangle = np.linalg.qr(s[:, None] ** power * samples.values[:, :count])
    inverse_triangle = np.linalg.inv(triangle)
    g = inverse_triangle @ (orthogonal.T @ heights)
    g = g + inverse_triangle @ (orthogonal.T @ (heights - (orthogonal @ (triangle @ g))))

    # The bracket and its derivative by s at s = 0 and s = 1 are linear in g.
    coordinate = chebyshev.Chebyshev([0.5, 0.5], domain=[0.0, 1.0])
    terms = [chebyshev.Chebyshev(row, domain=[0.0, 1.0]) for row in np.eye(count)]
    brackets = [power * term + coordinate * term.deriv() for term in terms]
    ends = np.array([0.0, 1.0])
    values = np.stack([bracket(ends) for bracket in brackets], axis=1)
    rates = np.stack([bracket.deriv()(ends) for bracket in brackets], axis=1)
    value_errors, rate_errors = (
        _STATED * rounding * np.linalg.norm(each @ inverse_triangle, axis=1)
        for each in (values, rates)
    )
    size = np.abs(values @ g)
    if not np.all(value_errors < _ROUGHEST * size):
        return None
    bracket = sum(share * each for share, each in zip(g.tolist(), brackets, strict=True))
    load_error = float(np.max(value_errors / size)) / _LEAST_LOAD
    # dP/da is of x h'' too: (2 m - 1) h' + 2 s times the rate of the bracket.
    stiffness_error = (
        2 * power * load_error + float(np.max(2 * ends * rate_errors / size)) / _LEAST_LOAD
    )
    return _Core(end, bracket, power - 1, rounding, Rounding(load_error, stiffness_error))
