"""Single rows of a trace that stand out from their neighbours: dust, and dropped readings.

A row is compared with the cubic through the four rows nearest to it in order. White noise of
standard deviation sigma makes a difference of sigma sqrt(1 + sum of the squares of the weights).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.array_types import Array

Rows = NDArray[np.int64]
# Differences over their standard deviation beyond which a row stands out: chance makes that of one
# row in two millions.
STANDS_OUT = 5.0
# Of the rows: more are no spikes but noise of another kind.
_SHARE_OF_SPIKES = 0.05
_N_NEIGHBOURS = 4


def rows_that_stand_out(x: Array, h: Array, sigma: float) -> Rows:
    """Rows (m,) of a measured trace that are spikes: they differ from the cubic through their four
    neighbours by more than five times what noise does. An empty array where they would be more
    than 5 % of the rows, or leave too few: then the noise is of another kind.

    The largest spike is removed first, since it moves the cubics of its neighbours too. At either
    end three rows share one cubic, so that all three are removed.

    Parameters
    ----------
    x, h
        (n,) places and heights
    sigma
        standard deviation of the noise of h, above 0

    Examples
    --------
    >>> x = np.arange(40.0)
    >>> h = x**2 + np.where(x == 12, 3.0, 0.0)
    >>> rows_that_stand_out(x, h, 0.1).tolist()
    [12]
    """
    rows_left = np.arange(len(x))
    spikes: list[int] = []
    while len(rows_left) > 2 * _N_NEIGHBOURS and len(spikes) <= _SHARE_OF_SPIKES * len(x):
        differences = _differences(x[rows_left], h[rows_left]) / sigma
        index_of_largest = int(np.argmax(differences))
        if differences[index_of_largest] <= STANDS_OUT:
            return np.array(sorted(spikes), dtype=np.int64)
        indices_of_spike = _alike(index_of_largest, len(rows_left))
        spikes += rows_left[indices_of_spike].tolist()
        rows_left = np.delete(rows_left, indices_of_spike)
    return np.array([], dtype=np.int64)


def _alike(place: int, count: int) -> list[int]:
    """Rows that are compared with the same window of five neighbouring rows as the row `place` of a
    table of `count` rows: itself, or three rows at either end.

    >>> _alike(1, 40), _alike(5, 40), _alike(39, 40)
    ([0, 1, 2], [5], [37, 38, 39])
    """
    half = _N_NEIGHBOURS // 2
    if place <= half:
        return list(range(half + 1))
    if place >= count - 1 - half:
        return list(range(count - 1 - half, count))
    return [place]


def _differences(x: Array, heights: Array) -> Array:
    """Distance of each row of a trace from the cubic through its four neighbours, (n,), over the
    standard deviation that noise of size 1 gives it; 0 where two of these rows have one x.

    With Lagrange's weights w_i of the neighbours that deviation is sqrt(1 + sum w_i^2). x and
    `heights` are (n,).
    """
    n_rows = len(x)
    n_before = _N_NEIGHBOURS // 2
    first_row = np.clip(np.arange(n_rows) - n_before, 0, n_rows - _N_NEIGHBOURS - 1)
    window_rows = first_row[:, None] + np.arange(_N_NEIGHBOURS + 1)
    is_itself = window_rows == np.arange(n_rows)[:, None]
    neighbours = window_rows[~is_itself].reshape(n_rows, _N_NEIGHBOURS)
    relative_places = x[neighbours]
    widths = relative_places[:, -1] - relative_places[:, 0]
    is_distinct = (np.min(np.diff(relative_places, axis=1), axis=1) > 0) & (widths > 0)
    relative_places = (relative_places - x[:, None]) / np.where(widths > 0, widths, 1.0)[:, None]
    # Weights of Lagrange's cubic at the row itself, which is the origin of places.
    weights = np.ones_like(relative_places)
    for i in range(_N_NEIGHBOURS):
        for j in range(_N_NEIGHBOURS):
            if j != i:
                distances = np.where(
                    is_distinct, relative_places[:, j] - relative_places[:, i], 1.0
                )
                weights[:, i] *= relative_places[:, j] / distances
    differences = heights - np.sum(weights * heights[neighbours], axis=1)
    sizes = np.abs(differences) / np.sqrt(1 + np.sum(weights**2, axis=1))
    return np.asarray(np.where(is_distinct, sizes, 0.0))
