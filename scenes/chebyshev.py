"""Smooth functions of one variable by piecewise Chebyshev series: values, differences without
cancellation, derivatives, roots.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from scenes.array_types import Array

Function = Callable[[Array], ArrayLike]

_MOST_PIECES = 400
_SHORTEST_PIECE = 1e-14
_LENGTH_AT_CORNER = 1e-3
_TERMS_AT_CORNER = 16
# Places at once, in arrays that fit into the cache.
_PLACES_PER_BLOCK = 4096

DEGREE = 24
"""Degree of every series."""

_N_TERMS = DEGREE + 1
_ODD_NUMBERS = 2 * np.arange(DEGREE, -1, -1) + 1
NODES = np.cos(_ODD_NUMBERS * (np.pi / (2 * _N_TERMS)))
"""Chebyshev points of the first kind on [-1, 1], ascending: the ends are not among them."""
# Angles within one turn: 24 times a rounded one would leave 3e-15 of a value in the last
# coefficients.
_TO_SERIES = np.cos(
    np.outer(_ODD_NUMBERS, np.arange(_N_TERMS)) % (4 * _N_TERMS) * (np.pi / (2 * _N_TERMS))
) * (2 / _N_TERMS)
_TO_SERIES[:, 0] /= 2


def series(values: ArrayLike) -> Array:
    """Coefficients (..., DEGREE + 1) from values at `NODES` on the last axis."""
    return np.asarray(values, dtype=float) @ _TO_SERIES


# Equal parts of a piece on each of which its series is a sum of powers about the middle: a fifth of
# the time of a recurrence.
_PARTS_OF_PIECE = 8
_MIDDLES_OF_PARTS = (2 * np.arange(_PARTS_OF_PIECE) + 1) / _PARTS_OF_PIECE - 1


@cache
def _to_parts() -> Array:
    """(_PARTS_OF_PIECE, _N_TERMS, _N_TERMS) from the coefficients of a series on [-1, 1] to those
    of the series on each part of it.
    """
    places_of_nodes = _MIDDLES_OF_PARTS[:, None] + NODES / _PARTS_OF_PIECE
    return np.asarray(_TO_SERIES.T @ chebyshev.chebvander(places_of_nodes, DEGREE))


@cache
def _to_powers() -> Array:
    """(_N_TERMS, _N_TERMS) from the coefficients of a series on a part to those of powers of s on
    [-1/2, 1/2].
    """
    powers_of_polynomials = [
        np.pad(chebyshev.cheb2poly(row[: k + 1]), (0, DEGREE - k))
        for k, row in enumerate(np.eye(_N_TERMS))
    ]
    return np.asarray(2.0 ** np.arange(_N_TERMS)[:, None] * np.transpose(powers_of_polynomials))


class Powers:
    """Chebyshev series on [-1, 1] as sums of powers: `coefficients` (k, n) of the series of n
    pieces, k up to DEGREE + 1.

    >>> float(
    ...     Powers(np.array([[0.0], [0.0], [1.0]]))(np.array(0), np.array(0.3)).round(12)
    ... )  # T_2 = 2 t^2 - 1
    -0.82
    """

    def __init__(self, coefficients: Array) -> None:
        """Convert Chebyshev series (k, n) of n pieces to sums of powers on eight parts of each
        piece; powers that are round-off on every part are dropped.
        """
        coefficients_on_parts = _to_parts()[..., : len(coefficients)] @ coefficients
        is_needed = np.any(
            np.abs(coefficients_on_parts)
            > 5e-16 * np.max(np.abs(coefficients_on_parts), axis=(0, 1)),
            axis=(0, 2),
        )
        n_powers = int(np.max(np.flatnonzero(is_needed), initial=0)) + 1
        self._rows = np.moveaxis(
            _to_powers()[:n_powers, :n_powers] @ coefficients_on_parts[:, :n_powers], 0, 2
        ).reshape(n_powers, -1)

    def __call__(self, number: NDArray[np.intp], t: Array) -> Array:
        """Values at places t of the series with these numbers, by Horner's rule on the part of the
        piece in which t lies.

        `number` and `t` have one shape, that of the result. t is in [-1, 1]; outside, the powers of
        the first or last part are continued.
        """
        place_in_parts = (np.ravel(t) + 1) * (_PARTS_OF_PIECE / 2)
        part_number = np.clip(place_in_parts.astype(np.intp), 0, _PARTS_OF_PIECE - 1)
        place_in_parts -= part_number
        place_in_parts -= 0.5
        part_number += np.ravel(number) * _PARTS_OF_PIECE
        values = self._rows[-1].take(part_number)
        row_values = np.empty(len(place_in_parts))
        for coefficients in self._rows[-2::-1]:
            values *= place_in_parts
            values += coefficients.take(part_number, out=row_values, mode="clip")
        return values.reshape(np.shape(t))


def tail(coefficients: Array) -> Array:
    """What the last coefficients are worth, shape (...,): an estimate of what was left out."""
    return np.max(np.abs(coefficients[..., -3:]), axis=-1)


@dataclass(frozen=True, eq=False)
class Pieces:
    """A function on [edges[0], edges[-1]], a Chebyshev series on each piece.

    Attributes
    ----------
    edges
        (n + 1,) ascending
    coefficients
        (DEGREE + 1, n)
    """

    edges: Array
    coefficients: Array

    def __call__(self, x: ArrayLike) -> Array:
        """Value of the function at x, any shape; outside its range, that of the first or last
        piece's series continued.
        """
        x_array = np.asarray(x, dtype=float)
        number = np.clip(
            np.searchsorted(self.edges, x_array, side="right") - 1, 0, len(self.edges) - 2
        )
        piece_begin = self.edges[number]
        piece_end = self.edges[number + 1]
        return self._powers(
            number, (2 * x_array - piece_begin - piece_end) / (piece_end - piece_begin)
        )

    @cached_property
    def _powers(self) -> Powers:
        return Powers(self.coefficients)

    @cached_property
    def derivative(self) -> Pieces:
        """dF/dx piece by piece; loses about DEGREE^2 roundings."""
        slope = chebyshev.chebder(self.coefficients) * (2 / np.diff(self.edges))
        return Pieces(self.edges, np.concatenate([slope, np.zeros((1, slope.shape[1]))]))


def clenshaw(coefficients: Array, number: NDArray[np.intp], t: Array) -> Array:
    """Values of Chebyshev series at places t, by Clenshaw's recurrence: the sum over k of
    coefficients[k, number] T_k(t), in the shape of t.

    Parameters
    ----------
    coefficients
        (n_terms, n_series)
    number
        which series counts at each place, in the shape of t
    t
        places in [-1, 1]
    """
    pieces = np.ravel(number)
    places = np.ravel(t)
    sums = np.empty(np.size(t))
    for begin in range(0, len(places), _PLACES_PER_BLOCK):
        chunk = slice(begin, begin + _PLACES_PER_BLOCK)
        piece = pieces[chunk]
        place = places[chunk]
        double_place = 2 * place
        # notation: b_k = c_k + 2 t b_(k+1) - b_(k+2), Clenshaw's recurrence
        b, b_1, b_2, product = np.zeros((4, len(place)))
        for row in coefficients[:0:-1]:
            row.take(piece, out=b, mode="clip")
            b -= b_2
            b += np.multiply(double_place, b_1, out=product)
            b_1, b_2, b = b, b_1, b_2
        sums[chunk] = place * b_1 - b_2 + coefficients[0].take(piece)
    return sums.reshape(np.shape(t))


def difference(coefficients: Array, t: Any, t_before: Any) -> Any:
    """Divided difference of a Chebyshev series F between two places, (F(t) - F(t_before)) /
    (t - t_before), without cancellation however close they are.

    Differences D_k of T_k follow by recurrence from T_(k+1) = 2 t T_k - T_(k-1):

        D_(k+1) = 2 (t D_k + T_k(t_before)) - D_(k-1)

    Parameters
    ----------
    coefficients
        (n,) of F = sum c_k T_k
    t, t_before
        places in [-1, 1], any shape; of two floats a float, in a tenth of the time

    Examples
    --------
    >>> float(difference(np.array([0.0, 0.0, 1.0]), np.array(0.3), np.array(0.3)))  # T_2' = 4 t
    1.2
    """
    sum_of_places = t + t_before
    unit = 1.0 if isinstance(sum_of_places, float) else np.ones_like(sum_of_places)
    difference_before = 0.0 * unit
    difference_now = unit
    value_before = unit
    value = t_before * unit
    divided_difference = 0.0 * unit
    for coefficient in coefficients[1:].tolist():
        divided_difference = divided_difference + coefficient * difference_now
        next_difference = 2 * (t * difference_now + value) - difference_before
        next_value = 2 * t_before * value - value_before
        difference_before = difference_now
        difference_now = next_difference
        value_before = value
        value = next_value
    return divided_difference


def fit(function: Function, edges: ArrayLike, scale: float | None = None) -> Pieces:
    """Approximate a function to rounding by Chebyshev series on intervals: those between `edges`,
    halved until each series is accurate.

    Accurate means: to 1e-13 of the largest value on the interval, to 1e-15 of that on the next one,
    or to 4e-15 of `scale`. A corner of the function leaves a run of very short intervals. It is
    then located, becomes an end of two intervals, and all is fitted again.

    Parameters
    ----------
    function
        takes an array of places, returns one of values
    edges
        (n,) ascending places, the ends of the first intervals
    scale
        size of values beside which errors are negligible

    Raises
    ------
    Unresolved
        Where halving does not help: noise, a pole, a function that is too rough.
    """
    piece_ends = np.asarray(edges, dtype=float)
    first_pieces = halved(function, piece_ends, scale)
    runs_of_short = _short_runs(first_pieces, piece_ends)
    if not runs_of_short:
        return first_pieces
    piece_ends = np.union1d(
        piece_ends, [_corner(function, first_pieces, run) for run in runs_of_short]
    )
    pieces = halved(function, piece_ends, scale)
    runs_left = _short_runs(pieces, piece_ends)
    if runs_left:
        raise Unresolved(float(pieces.edges[runs_left[0][0]]), float(pieces.edges[runs_left[0][1]]))
    return pieces


class Unresolved(ValueError):
    """A function that piecewise series can't follow between `low` and `high`."""

    def __init__(self, low: float, high: float) -> None:
        self.low = low
        self.high = high
        super().__init__(f"too rough between {low:.6g} and {high:.6g}")


def halved(function: Function, edges: Array, scale: ArrayLike | None = None) -> Pieces:
    """Approximate a function by Chebyshev series on intervals, halving all those whose series is
    not accurate to rounding yet, in turns.

    No interval gets shorter than 1e-14 of the first ones, so that a corner ends the halving after
    47 turns at most.

    Parameters
    ----------
    function
        takes an array of places, returns one of values
    edges
        (n + 1,) ascending places, the ends of the first intervals
    scale
        size of values beside which errors are negligible: one number, or (n,)

    Raises
    ------
    Unresolved
        Where values are no numbers, or one of the first intervals needs more than 400 parts.
    """

    def values_between(begins: Array, ends: Array) -> Array:
        """(m, DEGREE + 1) values of the function at the Chebyshev points of m intervals."""
        places = begins[:, None] + (ends - begins)[:, None] * (1 + NODES) / 2
        return np.asarray(function(places), dtype=float)

    begins = edges[:-1]
    ends = edges[1:]
    first_piece = np.arange(len(edges) - 1)  # which first interval each one is a part of
    shortest = np.maximum(
        _SHORTEST_PIECE * (ends - begins), 4e-16 * np.maximum(np.abs(begins), np.abs(ends))
    )
    values = values_between(begins, ends)
    largest_values = np.max(np.abs(values), axis=1)
    scales = np.zeros(len(begins)) if scale is None else np.asarray(scale, dtype=float)
    # The values on the next interval count too: a function may be zero on one.
    negligible_value = np.maximum(
        1e-15 * np.maximum(largest_values, np.append(largest_values[1:], 0.0)), 4e-15 * scales
    )
    begins_resolved = [begins[:0]]
    series_resolved = [np.empty((0, DEGREE + 1))]
    n_pieces = np.zeros(len(begins), dtype=int)
    while len(begins):
        coefficients = series(values)
        n_pieces = n_pieces + np.bincount(first_piece, minlength=len(n_pieces))
        tail_limits = np.maximum(
            1e-13 * np.max(np.abs(values), axis=1), negligible_value[first_piece]
        )
        is_rough = (tail(coefficients) > tail_limits) & (ends - begins > shortest[first_piece])
        rough_pieces = np.flatnonzero(
            ~np.all(np.isfinite(values), axis=1)
            | (is_rough & (n_pieces[first_piece] > _MOST_PIECES))
        )
        if len(rough_pieces):
            raise Unresolved(float(begins[rough_pieces[0]]), float(ends[rough_pieces[0]]))
        begins_resolved.append(begins[~is_rough])
        series_resolved.append(coefficients[~is_rough])
        begins = begins[is_rough]
        ends = ends[is_rough]
        first_piece = np.tile(first_piece[is_rough], 2)
        middle = (begins + ends) / 2
        begins = np.append(begins, middle)
        ends = np.append(middle, ends)
        if len(begins):
            values = values_between(begins, ends)
    ascending = np.argsort(np.concatenate(begins_resolved))
    return Pieces(
        np.append(np.concatenate(begins_resolved)[ascending], edges[-1]),
        np.concatenate(series_resolved)[ascending].T.copy(),
    )


def _short_runs(pieces: Pieces, edges: Array) -> list[tuple[int, int]]:
    """Runs of neighbouring intervals that halving has left far shorter than the first ones, as next
    to a corner of the function: (first, last + 1) of each run.

    `edges` are the ends of the first intervals, `pieces` the halved ones.
    """
    piece_lengths = np.diff(pieces.edges)
    lengths_between_edges = np.diff(edges)[
        np.searchsorted(edges, pieces.edges[:-1], side="right") - 1
    ]
    is_short = np.concatenate(
        [[False], piece_lengths < _LENGTH_AT_CORNER * lengths_between_edges, [False]]
    ).astype(int)
    return list(
        zip(
            np.flatnonzero(np.diff(is_short) == 1).tolist(),
            np.flatnonzero(np.diff(is_short) == -1).tolist(),
            strict=True,
        )
    )


def _corner(function: Function, pieces: Pieces, run: tuple[int, int]) -> float:
    """Place of a corner of a function, where halving has left a run of very short intervals.

    Smooth fits from the left and from the right of the run are continued into it. The corner is
    where they cross, or, if they only touch, where their slopes are equal. Of several such places
    the one nearest to the shortest interval counts.

    Parameters
    ----------
    pieces
        the halved intervals
    run
        indices of the first and of the last end of an interval in the run
    """
    begin, end = (float(pieces.edges[index]) for index in run)
    shortest_piece = run[0] + int(np.argmin(np.diff(pieces.edges[run[0] : run[1] + 1])))
    middle_of_shortest = float(pieces.edges[shortest_piece] + pieces.edges[shortest_piece + 1]) / 2
    # Each fit is over 50 lengths of the run, or as far as the function is given.
    width = min(
        50 * (end - begin),
        begin - float(pieces.edges[0]) or np.inf,
        float(pieces.edges[-1]) - end or np.inf,
    )
    left_fit, right_fit = (
        chebyshev.Chebyshev(
            series(function(interval_begin + width * (1 + NODES) / 2))[:_TERMS_AT_CORNER],
            domain=[interval_begin, interval_begin + width],
        )
        for interval_begin in (begin - width, end)
    )
    jump_series = chebyshev.Chebyshev.interpolate(
        lambda x: right_fit(x) - left_fit(x), 3, [begin, end]
    )
    fits_cross = jump_series(begin) * jump_series(end) < 0
    root_places = (jump_series if fits_cross else jump_series.deriv()).roots().real
    return float(
        min(
            root_places,
            key=lambda place: abs(place - middle_of_shortest),
            default=middle_of_shortest,
        )
    )


def values_of(function: Any) -> Callable[[Array], Array]:
    """Make a user's `function` of one variable take arrays of any shape: the returned function
    calls it once with the array, or point by point where it cannot take arrays.
    """

    def over(x: Array) -> Array:
        """Values of the function at all x, in one call or, where it can't take an array, one by
        one.
        """
        try:
            values = np.asarray(function(x), dtype=float)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape != x.shape:
            values = np.array([float(function(float(at))) for at in x.ravel()]).reshape(x.shape)
        return values

    return over
