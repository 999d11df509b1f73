"""Smooth functions of one variable by piecewise Chebyshev series: values, differences without
cancellation, derivatives, roots.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from scenes.array_types import Array

Function = Callable[[Array], ArrayLike]

# Most series computed for the parts of one first interval: of noise, halving would never end.
_MOST_PARTS = 400
# Length of an interval, over that of its first one, at which halving ends: round-off of places.
_SHORTEST_INTERVAL = 1e-14
# The same ratio, below which an interval has a corner of the function in it or beside it.
_LENGTH_AT_CORNER = 1e-3
# Of the series beside a corner, which is continued beyond its interval: higher terms would grow.
_TERMS_AT_CORNER = 16
# Places at once, in arrays that fit into the cache.
_PLACES_PER_BLOCK = 4096

CHEBYSHEV_DEGREE = 24
"""Degree of every series."""

_N_TERMS = CHEBYSHEV_DEGREE + 1
_ODD_NUMBERS = 2 * np.arange(CHEBYSHEV_DEGREE, -1, -1) + 1
CHEBYSHEV_NODES = np.cos(_ODD_NUMBERS * (np.pi / (2 * _N_TERMS)))
"""Chebyshev points of the first kind on [-1, 1], ascending: the ends are not among them."""
# Angles within one turn: 24 times a rounded one would leave 3e-15 of a value in the last
# coefficients.
_VALUES_TO_COEFFICIENTS = np.cos(
    np.outer(_ODD_NUMBERS, np.arange(_N_TERMS)) % (4 * _N_TERMS) * (np.pi / (2 * _N_TERMS))
) * (2 / _N_TERMS)
_VALUES_TO_COEFFICIENTS[:, 0] /= 2


def chebyshev_coefficients(values: ArrayLike) -> Array:
    """Chebyshev coefficients (..., CHEBYSHEV_DEGREE + 1) from values (..., CHEBYSHEV_DEGREE + 1) at
    `CHEBYSHEV_NODES`.
    """
    return np.asarray(values, dtype=float) @ _VALUES_TO_COEFFICIENTS


# Equal parts of an interval, on each of which its series is a sum of powers about the middle: a
# fifth of the time of a recurrence.
_PARTS_OF_INTERVAL = 8
_MIDDLES_OF_PARTS = (2 * np.arange(_PARTS_OF_INTERVAL) + 1) / _PARTS_OF_INTERVAL - 1


@cache
def _series_to_parts() -> Array:
    """Matrices that take the Chebyshev coefficients of a function on [-1, 1] to those of the same
    function on each of eight equal parts: (8 parts, 25 terms on the part, 25 terms).
    """
    places_of_nodes = _MIDDLES_OF_PARTS[:, None] + CHEBYSHEV_NODES / _PARTS_OF_INTERVAL
    return np.asarray(
        _VALUES_TO_COEFFICIENTS.T @ chebyshev.chebvander(places_of_nodes, CHEBYSHEV_DEGREE)
    )


@cache
def _terms_to_powers() -> Array:
    """Matrix (25 powers, 25 terms) that takes the Chebyshev coefficients of a function on an
    interval of length 1, s from -1/2 to 1/2, to the coefficients of the powers of s.
    """
    powers_of_polynomials = [
        np.pad(chebyshev.cheb2poly(row[: k + 1]), (0, CHEBYSHEV_DEGREE - k))
        for k, row in enumerate(np.eye(_N_TERMS))
    ]
    return np.asarray(2.0 ** np.arange(_N_TERMS)[:, None] * np.transpose(powers_of_polynomials))


class SeriesAsPowers:
    """Several Chebyshev series of t in [-1, 1], converted to sums of powers, which take a fifth of
    the time to evaluate: `coefficients` (k, n) of n series, k up to CHEBYSHEV_DEGREE + 1.

    >>> float(
    ...     SeriesAsPowers(np.array([[0.0], [0.0], [1.0]]))(np.array(0), np.array(0.3)).round(12)
    ... )  # T_2 = 2 t^2 - 1
    -0.82
    """

    def __init__(self, coefficients: Array) -> None:
        """Convert n Chebyshev series on [-1, 1], coefficients (k, n), to sums of powers, stored for
        evaluation in the attribute `_power_coefficients`.

        [-1, 1] is divided into _PARTS_OF_INTERVAL = 8 equal parts, each with a sum of powers of its
        own about its middle: on the whole interval powers would lose digits. Before that the
        highest Chebyshev terms are dropped, where they are round-off on every part of every series.
        """
        # `_series_to_parts()` takes the coefficients on [-1, 1] to those on each part.
        # Axes: part, Chebyshev term, series.
        series_on_parts = _series_to_parts()[..., : len(coefficients)] @ coefficients
        term_sizes = np.abs(series_on_parts)

        # Orders whose term is above round-off on some part of some series.
        is_needed = np.any(term_sizes > 5e-16 * np.max(term_sizes, axis=(0, 1)), axis=(0, 2))
        n_powers = int(np.max(np.flatnonzero(is_needed), initial=0)) + 1

        # Axes: part, power, series. `_terms_to_powers()` takes Chebyshev terms to powers.
        powers_on_parts = _terms_to_powers()[:n_powers, :n_powers] @ series_on_parts[:, :n_powers]
        # (n_powers, 8 n): column 8 i + j is part j of series i.
        self._power_coefficients = np.moveaxis(powers_on_parts, 0, 2).reshape(n_powers, -1)

    def __call__(self, function_number: NDArray[np.intp], t: Array) -> Array:
        """Values of several functions, each a sum of powers on parts of [-1, 1], at places t in
        [-1, 1], by Horner's rule, in the shape of t; outside, the powers of the first or last part
        are continued.

        `function_number` is the index, 0 to n - 1, of the function that is evaluated at each place,
        in the shape of t.
        """
        # Distances from -1 in lengths of a part, and the part (0 to 7) of each place.
        distance_in_parts = (np.ravel(t) + 1) * (_PARTS_OF_INTERVAL / 2)
        part = np.clip(distance_in_parts.astype(np.intp), 0, _PARTS_OF_INTERVAL - 1)
        # From the middle of the part, in [-1/2, 1/2]; in place, since this is the innermost loop of
        # many integrals.
        place_in_part = distance_in_parts
        place_in_part -= part
        place_in_part -= 0.5
        # Column of the part's powers, also in place; `_PARTS_OF_INTERVAL`: 8 a function.
        column = np.ravel(function_number) * _PARTS_OF_INTERVAL
        column += part

        # Horner's rule from the highest power down.
        # `_power_coefficients` (n_powers, 8 n): a row for each power, a column for each part.
        values = self._power_coefficients[-1].take(column)
        next_coefficients = np.empty(len(place_in_part))
        for coefficients_of_power in self._power_coefficients[-2::-1]:
            values *= place_in_part
            values += coefficients_of_power.take(column, out=next_coefficients, mode="clip")
        return values.reshape(np.shape(t))


def truncation_error(coefficients: Array) -> Array:
    """Largest size of the last three coefficients (..., k) of Chebyshev series, (...,): an estimate
    of the truncation error.
    """
    return np.max(np.abs(coefficients[..., -3:]), axis=-1)


@dataclass(frozen=True, eq=False)
class PiecewiseSeries:
    """A piecewise Chebyshev series: a function on n neighbouring intervals, with a series of its
    own on each.

    Attributes
    ----------
    interval_ends
        (n + 1,) ascending ends of the intervals
    coefficients
        (CHEBYSHEV_DEGREE + 1, n), a column for each interval
    """

    interval_ends: Array
    coefficients: Array

    def __call__(self, x: ArrayLike) -> Array:
        """Values of a piecewise Chebyshev series at x, in its shape; beyond the first or last
        interval, those of its series continued.

        `interval_ends` (n + 1,) are the ascending ends of the n intervals. Each has a series.
        """
        x_array = np.asarray(x, dtype=float)
        # Index of the interval of each x.
        interval_index = np.clip(
            np.searchsorted(self.interval_ends, x_array, side="right") - 1,
            0,
            len(self.interval_ends) - 2,
        )
        begin = self.interval_ends[interval_index]
        end = self.interval_ends[interval_index + 1]
        place_in_interval = (2 * x_array - begin - end) / (end - begin)
        # `_powers` evaluates the series of that number at t in [-1, 1].
        return self._powers(interval_index, place_in_interval)

    @cached_property
    def _powers(self) -> SeriesAsPowers:
        return SeriesAsPowers(self.coefficients)

    @cached_property
    def derivative(self) -> PiecewiseSeries:
        """dF/dx on the same intervals; its round-off is about 600 times that of F, the square
        of the degree.
        """
        derivative_coefficients = chebyshev.chebder(self.coefficients) * (
            2 / np.diff(self.interval_ends)
        )
        return PiecewiseSeries(
            self.interval_ends,
            np.concatenate(
                [derivative_coefficients, np.zeros((1, derivative_coefficients.shape[1]))]
            ),
        )


def clenshaw_values(coefficients: Array, series_number: NDArray[np.intp], t: Array) -> Array:
    """Values of several Chebyshev series, one of them at each place t, by Clenshaw's recurrence:
    the sum over k of coefficients[k, series_number] T_k(t), in the shape of t.

    Parameters
    ----------
    coefficients
        (n_terms, n_series)
    series_number
        index of the series that is evaluated at each place, in the shape of t
    t
        places in [-1, 1]
    """
    series_of_places = np.ravel(series_number)
    places = np.ravel(t)
    sums = np.empty(np.size(t))
    # Blocks of 4,096 places fit into the cache.
    for begin in range(0, len(places), _PLACES_PER_BLOCK):
        block = slice(begin, begin + _PLACES_PER_BLOCK)
        series_of_block = series_of_places[block]
        block_places = places[block]
        doubled_places = 2 * block_places
        # notation: b_k = c_k + 2 t b_(k+1) - b_(k+2), Clenshaw's recurrence, c_k the coefficient of
        # T_k; b, b_1, b_2 are b_k, b_(k+1), b_(k+2)
        b, b_1, b_2, product = np.zeros((4, len(block_places)))
        for coefficients_of_term in coefficients[:0:-1]:
            coefficients_of_term.take(series_of_block, out=b, mode="clip")
            b -= b_2
            b += np.multiply(doubled_places, b_1, out=product)
            b_1, b_2, b = b, b_1, b_2
        sums[block] = block_places * b_1 - b_2 + coefficients[0].take(series_of_block)
    return sums.reshape(np.shape(t))


def divided_difference(coefficients: Array, t: Any, t_before: Any) -> Any:
    """Divided difference of a Chebyshev series F between two places, (F(t) - F(t_before)) /
    (t - t_before), without cancellation however close they are.

    The divided differences D_k of T_k follow by recurrence from T_(k+1) = 2 t T_k - T_(k-1):

        D_(k+1) = 2 (t D_k + T_k(t_before)) - D_(k-1)

    Parameters
    ----------
    coefficients
        (n,) of F = sum c_k T_k
    t, t_before
        places in [-1, 1], any shape; of two floats a float, in a tenth of the time

    Examples
    --------
    >>> float(
    ...     divided_difference(np.array([0.0, 0.0, 1.0]), np.array(0.3), np.array(0.3))
    ... )  # T_2' = 4 t
    1.2
    """
    sum_of_places = t + t_before

    unit_values = 1.0 if isinstance(sum_of_places, float) else np.ones_like(sum_of_places)
    # notation: d_k = D_k of T_k, t_k = T_k(t_before)
    d_before = 0.0 * unit_values  # D_0
    d_k = unit_values  # D_1
    t_k_before = unit_values  # T_0
    t_k = t_before * unit_values  # T_1
    quotient = 0.0 * unit_values

    # Each term adds c_k D_k; the recurrences of D_k and T_k give the next ones.
    for coefficient in coefficients[1:].tolist():
        quotient = quotient + coefficient * d_k
        d_next = 2 * (t * d_k + t_k) - d_before
        t_k_next = 2 * t_before * t_k - t_k_before
        d_before = d_k
        d_k = d_next
        t_k_before = t_k
        t_k = t_k_next
    return quotient


def piecewise_series_of(
    function: Function, first_interval_ends: ArrayLike, scale: float | None = None
) -> PiecewiseSeries:
    """Approximate a function by a piecewise Chebyshev series to round-off: given intervals are
    halved until the series on each part is accurate.

    Accurate means: to 1e-13 of the largest value on the interval, to 1e-15 of that on its first
    interval or the next one, or to 4e-15 of `scale`. A corner (jump of the slope) leaves a run of
    very short intervals. It is then located, becomes an end of two intervals, and all is fitted
    again.

    Parameters
    ----------
    function
        takes an array of places, returns one of values
    first_interval_ends
        (n,) ascending places, the ends of the first intervals
    scale
        size of values beside which errors are negligible

    Raises
    ------
    UnresolvedError
        Where halving does not help: noise, a pole, a function that is too rough.
    """
    first_ends = np.asarray(first_interval_ends, dtype=float)
    # The function on intervals that were halved until each series is accurate.
    halved_series = piecewise_series_by_halving(function, first_ends, scale)
    # Runs of very short intervals, as halving leaves them next to a corner: indices in
    # `halved_series.interval_ends` of begin and end of each.
    runs_at_corners = _runs_of_short_intervals(halved_series, first_ends)
    if not runs_at_corners:
        return halved_series

    # Corners become ends of first intervals, and all is fitted again.
    corners = [_place_of_corner(function, halved_series, run) for run in runs_at_corners]
    ends_with_corners = np.union1d(first_ends, corners)
    halved_series = piecewise_series_by_halving(function, ends_with_corners, scale)
    runs_at_corners = _runs_of_short_intervals(halved_series, ends_with_corners)

    if runs_at_corners:
        first_run_begin, first_run_end = runs_at_corners[0]
        raise UnresolvedError(
            float(halved_series.interval_ends[first_run_begin]),
            float(halved_series.interval_ends[first_run_end]),
        )
    return halved_series


class UnresolvedError(ValueError):
    """A function that piecewise series can't follow between `low` and `high`."""

    def __init__(self, low: float, high: float) -> None:
        self.low = low
        self.high = high
        super().__init__(f"too rough between {low:.6g} and {high:.6g}")


def piecewise_series_by_halving(
    function: Function, first_interval_ends: Array, scale: ArrayLike | None = None
) -> PiecewiseSeries:
    """Approximate a function by a piecewise Chebyshev series: intervals whose series is not yet
    accurate to round-off are halved, all of them in each turn, until none is left.

    No interval gets shorter than 1e-14 of its first one, so that a corner (jump of the slope) ends
    the halving after 47 turns at most.

    Parameters
    ----------
    function
        takes an array of places, returns one of values
    first_interval_ends
        (n + 1,) ascending places, the ends of the n first intervals
    scale
        size of values beside which errors are negligible: one number, or (n,) for the first
        intervals

    Raises
    ------
    UnresolvedError
        Where values are no numbers, or a first interval would be divided into more than 400.
    """
    # The intervals that are not accurate yet, (m,). At the beginning these are the first intervals
    # themselves.
    intervals = _Intervals(
        first_interval_ends[:-1], first_interval_ends[1:], np.arange(len(first_interval_ends) - 1)
    )
    values = intervals.values_of(function)
    limits = _HalvingLimits.of_first_intervals(intervals, values, scale)
    # For each first interval: how many of its parts have been given a series.
    n_series = np.zeros(len(first_interval_ends) - 1, dtype=int)

    # Intervals that are not halved further: their begins, and the coefficients of their series,
    # CHEBYSHEV_DEGREE + 1 = 25 each.
    finished_begins = [intervals.begins[:0]]
    finished_coefficients = [np.empty((0, CHEBYSHEV_DEGREE + 1))]
    while len(intervals.begins):
        # One turn: a series on each interval, and whether it is accurate.
        coefficients = chebyshev_coefficients(values)
        n_series = n_series + np.bincount(intervals.first_interval, minlength=len(n_series))
        is_to_be_halved = limits.can_be_halved(intervals) & (
            truncation_error(coefficients) > limits.largest_errors(values, intervals)
        )
        # _MOST_PARTS: 400 series for the parts of one first interval
        has_too_many_parts = is_to_be_halved & (n_series[intervals.first_interval] > _MOST_PARTS)
        intervals.require_resolved(~np.all(np.isfinite(values), axis=1) | has_too_many_parts)
        finished_begins.append(intervals.begins[~is_to_be_halved])
        finished_coefficients.append(coefficients[~is_to_be_halved])
        intervals = intervals.halved(is_to_be_halved)
        if len(intervals.begins):
            values = intervals.values_of(function)

    all_begins = np.concatenate(finished_begins)
    ascending_order = np.argsort(all_begins)
    return PiecewiseSeries(
        np.append(all_begins[ascending_order], first_interval_ends[-1]),
        np.concatenate(finished_coefficients)[ascending_order].T.copy(),
    )


class _Intervals(NamedTuple):
    """Intervals of x, (m,): their two ends, and the number of the first interval that each is a
    part of.
    """

    begins: Array
    ends: Array
    first_interval: NDArray[np.intp]

    def values_of(self, function: Function) -> Array:
        """Values of a function at the Chebyshev points of the intervals, one row each, (m,
        nodes)."""
        # CHEBYSHEV_NODES: Chebyshev points on [-1, 1]
        places = (
            self.begins[:, None] + (self.ends - self.begins)[:, None] * (1 + CHEBYSHEV_NODES) / 2
        )
        return np.asarray(function(places), dtype=float)

    def require_resolved(self, is_unresolved: NDArray[np.bool_]) -> None:
        """Raise UnresolvedError for the first interval, if any, on which a function cannot be
        resolved; `is_unresolved` (m,) is true for these.
        """
        if np.any(is_unresolved):
            number = int(np.argmax(is_unresolved))
            raise UnresolvedError(float(self.begins[number]), float(self.ends[number]))

    def halved(self, is_to_be_halved: NDArray[np.bool_]) -> _Intervals:
        """The halves of some intervals, (m,) true for these: all left halves, then all right
        ones."""
        begins = self.begins[is_to_be_halved]
        ends = self.ends[is_to_be_halved]
        middles = (begins + ends) / 2
        return _Intervals(
            np.append(begins, middles),
            np.append(middles, ends),
            np.tile(self.first_interval[is_to_be_halved], 2),
        )


class _HalvingLimits(NamedTuple):
    """Limits at which intervals are halved no more, (n,) for all parts of each of n first
    intervals: least length of a part, and error of a series that is negligible.
    """

    least_length: Array
    negligible_error: Array

    @classmethod
    def of_first_intervals(
        cls, intervals: _Intervals, values: Array, scale: ArrayLike | None
    ) -> _HalvingLimits:
        """The limits from the n first intervals and the values (n, nodes) of the function on them.
        `scale` is a size of values beside which errors are negligible: a number, (n,), or None.

        A part has at least 1e-14 of the length of its first interval. Negligible is 1e-15 of the
        largest value on an interval or on the next one, since a function may be zero on one; or
        4e-15 of `scale`.
        """
        begins, ends, _ = intervals
        # _SHORTEST_INTERVAL: 1e-14 of the length
        least_length = np.maximum(
            _SHORTEST_INTERVAL * (ends - begins), 4e-16 * np.maximum(np.abs(begins), np.abs(ends))
        )
        largest_values = np.max(np.abs(values), axis=1)
        scales = np.zeros(len(begins)) if scale is None else np.asarray(scale, dtype=float)
        negligible_error = np.maximum(
            1e-15 * np.maximum(largest_values, np.append(largest_values[1:], 0.0)), 4e-15 * scales
        )
        return cls(least_length, negligible_error)

    def can_be_halved(self, intervals: _Intervals) -> NDArray[np.bool_]:
        """Whether each of m parts is longer than the least length, (m,)."""
        lengths = intervals.ends - intervals.begins
        return lengths > self.least_length[intervals.first_interval]

    def largest_errors(self, values: Array, intervals: _Intervals) -> Array:
        """Largest error that a series may have, on m parts, (m,): 1e-13 of the largest value on the
        part, or what is negligible. `values` (m, nodes) are those of the function on the parts.
        """
        return np.maximum(
            1e-13 * np.max(np.abs(values), axis=1), self.negligible_error[intervals.first_interval]
        )


def _runs_of_short_intervals(
    halved_series: PiecewiseSeries, first_ends: Array
) -> list[tuple[int, int]]:
    """Runs of neighbouring intervals that halving has left shorter than a thousandth of the first
    ones, as it does next to a corner.

    Returned for each run: the indices in `halved_series.interval_ends` of its begin and its end.

    Parameters
    ----------
    halved_series
        series on the halved intervals; `interval_ends` are the ascending ends of all
    first_ends
        (n + 1,) ends of the first intervals, before halving
    """
    interval_begins = halved_series.interval_ends[:-1]
    interval_lengths = np.diff(halved_series.interval_ends)
    first_interval_index = np.searchsorted(first_ends, interval_begins, side="right") - 1
    first_lengths = np.diff(first_ends)[first_interval_index]
    # 1 for a short interval, 0 before the first and after the last: a run begins where it changes
    # from 0 to 1, and ends where it changes back.
    # _LENGTH_AT_CORNER: 1e-3 of the first interval
    is_short = np.concatenate(
        [[False], interval_lengths < _LENGTH_AT_CORNER * first_lengths, [False]]
    ).astype(int)
    run_begins = np.flatnonzero(np.diff(is_short) == 1)
    run_ends = np.flatnonzero(np.diff(is_short) == -1)
    return list(zip(run_begins.tolist(), run_ends.tolist(), strict=True))


def _place_of_corner(
    function: Function, halved_series: PiecewiseSeries, run: tuple[int, int]
) -> float:
    """Place of a corner (jump of the slope) of a function, within a run of very short intervals
    that halving has left next to it.

    Chebyshev series fitted on the left and on the right of the run are continued into it. The
    corner is where they cross, or, if they only touch, where their slopes are equal. Of several
    such places it is the one nearest to the shortest interval; without any it is the middle of that
    interval.

    Parameters
    ----------
    function
        takes an array of places, returns one of values
    halved_series
        series on the halved intervals; `interval_ends` are the ascending ends of all
    run
        indices in `halved_series.interval_ends` of the begin and the end of the run
    """
    interval_ends = halved_series.interval_ends
    first_index, last_index = run
    run_begin = float(interval_ends[first_index])
    run_end = float(interval_ends[last_index])
    # The shortest interval of the run: halving has gone deepest there.
    lengths = np.diff(interval_ends[first_index : last_index + 1])
    shortest_interval = first_index + int(np.argmin(lengths))
    middle_of_shortest = (
        float(interval_ends[shortest_interval] + interval_ends[shortest_interval + 1]) / 2
    )
    # Each fit is over 50 lengths of the run, or as far as the function is given.
    fit_width = min(
        50 * (run_end - run_begin),
        run_begin - float(interval_ends[0]) or np.inf,
        float(interval_ends[-1]) - run_end or np.inf,
    )

    def fit_from(place: float) -> chebyshev.Chebyshev:
        """Series of the function from a place on, over the width of a fit."""
        # CHEBYSHEV_NODES: Chebyshev points on [-1, 1]
        values = function(place + fit_width * (1 + CHEBYSHEV_NODES) / 2)
        # _TERMS_AT_CORNER: 16, since higher terms grow where the series is continued
        return chebyshev.Chebyshev(
            chebyshev_coefficients(values)[:_TERMS_AT_CORNER], domain=[place, place + fit_width]
        )

    # The difference of both fits on the run, a cubic.
    left_fit = fit_from(run_begin - fit_width)
    right_fit = fit_from(run_end)
    fit_difference = chebyshev.Chebyshev.interpolate(
        lambda x: right_fit(x) - left_fit(x), 3, [run_begin, run_end]
    )
    fits_cross = fit_difference(run_begin) * fit_difference(run_end) < 0
    candidate_places = (fit_difference if fits_cross else fit_difference.deriv()).roots().real
    return float(
        min(
            candidate_places,
            key=lambda place: abs(place - middle_of_shortest),
            default=middle_of_shortest,
        )
    )


def function_of_arrays(function: Any) -> Callable[[Array], Array]:
    """Make a user's `function` of one variable take arrays: the returned function takes places x of
    any shape, and returns the values there in the same shape.

    It calls `function` once with the array, or place by place where `function` cannot take arrays.
    """

    def values_at(x: Array) -> Array:
        """Values of the function at all x, in their shape."""
        try:
            values = np.asarray(function(x), dtype=float)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape != x.shape:  # also a constant, of shape ()
            values = np.array([float(function(float(place))) for place in x.ravel()])
            values = values.reshape(x.shape)
        return values

    return values_at
