"""Single rows of a trace that stand out from their neighbours: dust, and dropped readings.

A row is compared with the cubic through the four rows nearest to it in order. White noise of
standard deviation sigma makes a difference of sigma sqrt(1 + sum of the squares of the weights).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.array_types import Array

Rows = NDArray[np.int64]
# Standardised residuals beyond which a row stands out: chance makes one of two million rows do so.
LEAST_RESIDUAL_OF_SPIKE = 5.0
LARGEST_FRACTION_OF_SPIKES = 0.05
"""Fraction of the rows above which those that stand out are noise of another kind, not spikes."""
_N_NEIGHBOURS = 4


def rows_that_stand_out(x: Array, h: Array, sigma: float) -> Rows:
    """Indices (m,), ascending, of the rows of a measured trace h(x) that are spikes: their
    standardised residual from the cubic through their four neighbours is above 5.

    Empty where they would be more than 5 % of the rows, or leave too few: the noise is then not
    white. The largest spike is removed first, since it moves the cubics of its neighbours too. The
    three rows at either end share one cubic, so that all three are removed.

    Parameters
    ----------
    x, h
        (n,) places, ascending, and heights [length]
    sigma
        standard deviation of the noise of h [length], above 0

    Examples
    --------
    >>> x = np.arange(40.0)
    >>> h = x**2 + np.where(x == 12, 3.0, 0.0)
    >>> rows_that_stand_out(x, h, 0.1).tolist()
    [12]
    """
    # Rows that are no spikes so far, and those that are.
    remaining_rows = np.arange(len(x))
    spike_rows: list[int] = []
    most_spikes = LARGEST_FRACTION_OF_SPIKES * len(x)
    while len(remaining_rows) > 2 * _N_NEIGHBOURS and len(spike_rows) <= most_spikes:
        # Difference of each row from its cubic, over the standard deviation of that by noise.
        residuals = _standardised_residuals(x[remaining_rows], h[remaining_rows]) / sigma
        index_of_largest_residual = int(np.argmax(residuals))
        if residuals[index_of_largest_residual] <= LEAST_RESIDUAL_OF_SPIKE:
            return np.array(sorted(spike_rows), dtype=np.int64)
        # The row, or near an end the three rows that share one cubic.
        indices_to_remove = _rows_with_same_window(index_of_largest_residual, len(remaining_rows))
        spike_rows += remaining_rows[indices_to_remove].tolist()
        remaining_rows = np.delete(remaining_rows, indices_to_remove)
    return np.array([], dtype=np.int64)


def _rows_with_same_window(row: int, n_rows: int) -> list[int]:
    """Indices of the rows whose window of five rows, themselves and their four neighbours, is that
    of `row`: it alone, or the first or last three of the `n_rows`.

    The window is centred on its row, but stays within the table: at either end three rows share it,
    and a spike in one of them cannot be told from one in the others.

    >>> _rows_with_same_window(1, 40), _rows_with_same_window(5, 40)
    ([0, 1, 2], [5])
    """
    # _N_NEIGHBOURS: 4 rows nearest to a row
    n_rows_before = _N_NEIGHBOURS // 2
    if row <= n_rows_before:
        return list(range(n_rows_before + 1))
    if row >= n_rows - 1 - n_rows_before:
        return list(range(n_rows - 1 - n_rows_before, n_rows))
    return [row]


def _standardised_residuals(x: Array, heights: Array) -> Array:
    """Residuals |h - cubic| of the rows of a trace, (n,), each over its standard deviation in white
    noise of standard deviation 1; 0 where two of a row's neighbours have one x.

    The cubic interpolates the row's four neighbours: at the row it is the sum of w_i h_i, w_i their
    Lagrange weights. The standard deviation is then sqrt(1 + sum of w_i^2). x and `heights` are
    (n,).
    """
    n_rows = len(x)
    # _N_NEIGHBOURS: 4 rows nearest to a row
    n_rows_before = _N_NEIGHBOURS // 2
    # Rows of each window of five: the row itself, and its four neighbours.
    first_rows = np.clip(np.arange(n_rows) - n_rows_before, 0, n_rows - _N_NEIGHBOURS - 1)
    window_rows = first_rows[:, None] + np.arange(_N_NEIGHBOURS + 1)
    is_row_itself = window_rows == np.arange(n_rows)[:, None]
    neighbours = window_rows[~is_row_itself].reshape(n_rows, _N_NEIGHBOURS)

    x_of_neighbours = x[neighbours]
    window_lengths = x_of_neighbours[:, -1] - x_of_neighbours[:, 0]
    is_distinct = (np.min(np.diff(x_of_neighbours, axis=1), axis=1) > 0) & (window_lengths > 0)
    nonzero_window_lengths = np.where(window_lengths > 0, window_lengths, 1.0)
    # Of the neighbours from the row, over the length of its window: the row itself is the origin.
    relative_distances = (x_of_neighbours - x[:, None]) / nonzero_window_lengths[:, None]
    lagrange_weights = np.ones_like(relative_distances)
    for i in range(_N_NEIGHBOURS):
        for j in range(_N_NEIGHBOURS):
            if j != i:
                distance_of_neighbours = np.where(
                    is_distinct, relative_distances[:, j] - relative_distances[:, i], 1.0
                )
                lagrange_weights[:, i] *= relative_distances[:, j] / distance_of_neighbours

    residuals = heights - np.sum(lagrange_weights * heights[neighbours], axis=1)
    standardised_residuals = np.abs(residuals) / np.sqrt(1 + np.sum(lagrange_weights**2, axis=1))
    return np.asarray(np.where(is_distinct, standardised_residuals, 0.0))
