"""Fewer rows for a long record: means of neighbours, turning points above a hysteresis threshold, a path within a tolerance."""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from scenes.measured import Table

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Reduction = Literal["turning_points", "tolerance"]
# Of the largest load: what rounding may make of a distance.
_ROUNDING = 1e-12


@lru_cache(maxsize=4)  # a record of two million rows takes seconds, and is asked for by each engine
def reduced(rows: Table, average: int, how: Reduction | None, normal: float, tangential: float) -> Array:
    """The rows (m, 3) of time, P and Q that stand for a record; of those that are kept the first and the last are two.

    Parameters
    ----------
    average : how many neighbouring rows are replaced by their mean first; 1 for none
    how : "turning_points": rows at which P or Q turns by more than the threshold, `normal` of P and `tangential` of Q.
        "tolerance": straight lines, each as long as it can be, that pass the other rows, in their order, at distances of at most
        `normal` in P and `tangential` in Q. None: all

    >>> record = Table.of([[0, 9, 0], [1, 9, 5], [2, 9, 4.9], [3, 9, 8], [4, 9, -8]])
    >>> reduced(record, 1, "turning_points", 0.0, 0.5)[:, 2].tolist()
    [0.0, 8.0, -8.0]
    >>> reduced(record, 2, None, 0.0, 0.0)[:, 2].tolist()
    [2.5, 6.45, -8.0]
    """
    values = means(rows.values, average)
    if how is None:
        found = values
    elif how == "turning_points":
        turns = (turning_points(values[:, column], size) for column, size in ((1, normal), (2, tangential)))
        found = values[np.unique(np.concatenate([[0, len(values) - 1], *turns]))]
    else:
        found = values[within(values[:, 1:], np.array([normal, tangential]))]
    found.flags.writeable = False
    return found


def means(values: Array, count: int) -> Array:
    """The mean of each `count` neighbouring rows; the last of them may be of fewer."""
    if count == 1:
        return values
    starts = np.arange(0, len(values), count)
    return np.asarray(np.add.reduceat(values, starts, axis=0) / np.diff(starts, append=len(values))[:, None])


def turning_points(values: Array, threshold: float) -> Rows:
    """Rows (m,) at which `values` (n,) turn, but for swings of at most `threshold`: an extreme counts once they left it by more."""
    step = np.diff(values)
    moved = np.flatnonzero(step)
    turned = moved[:-1][step[moved[:-1]] * step[moved[1:]] < 0] + 1  # the first row of a plateau that turns
    found: list[int] = []
    way, low, high = 0, 0, 0  # way of the swing that is followed, and its extreme rows so far
    for row, value in zip((*turned.tolist(), len(values) - 1), (*values[turned].tolist(), float(values[-1])), strict=True):
        high = row if value > values[high] else high
        low = row if value < values[low] else low
        if way >= 0 and values[high] - value > threshold:
            found.append(high)
            way, low = -1, row
        elif way <= 0 and value - values[low] > threshold:
            found.append(low)
            way, high = 1, row
    return np.array(found, dtype=np.int64)


def within(path: Array, tolerance: Array) -> Rows:
    """Rows (m,) whose straight lines pass all points (n, 2) of `path` in their order, each within `tolerance` (2,).

    From each kept row as far as doubled and halved steps find a line that does: the intervals of the line near each point must
    allow an order. A line is near the straight piece between two points where it is near both, since the distance is convex.
    """
    slack = tolerance + _ROUNDING * np.max(np.abs(path), initial=0.0)

    def fits(first: int, last: int) -> bool:
        start, way = path[first], path[last] - path[first]
        between = path[first + 1 : last] - start
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (between - slack) / way, (between + slack) / way
        still = way == 0
        if np.any(np.abs(between[:, still]) > slack[still]):
            return False
        low = np.max(np.where(still, 0.0, np.minimum(one, other)), axis=1, initial=0.0)
        high = np.min(np.where(still, 1.0, np.maximum(one, other)), axis=1, initial=1.0)
        return bool(np.all(np.maximum.accumulate(low) <= high))

    kept, last = [0], len(path) - 1
    while kept[-1] < last:
        first, reach = kept[-1], 1
        while first + 2 * reach <= last and fits(first, first + 2 * reach):
            reach *= 2
        far = min(2 * reach, last - first + 1)
        while far - reach > 1:  # `reach` fits, `far` does not or was not tried
            middle = (reach + far) // 2
            reach, far = (middle, far) if fits(first, first + middle) else (reach, middle)
        kept.append(first + reach)
    return np.array(kept, dtype=np.int64)
