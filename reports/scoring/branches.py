"""Of places on a path that are equally near to the loads of an instant, those that lie most evenly in time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.intp]
_BACK = 100.0  # a step back by noise next to a turn is some hundredths of a period; the other choice is a period ahead


def places(squares: Array, reach: float) -> Places:
    """First, nearest and last sample (n, 3) of each stretch of the path that comes within `reach`.

    `squares` are squared distances of the samples, (n_samples,).

    >>> places(np.array([4.0, 1.0, 0.0, 4.0, 1.0]), 1.0).tolist()
    [[1, 2, 2], [4, 4, 4]]
    """
    near = np.flatnonzero(squares <= reach**2)
    if not len(near):
        near = np.array([np.argmin(squares)])
    stretches = np.split(near, np.flatnonzero(np.diff(near) > 1) + 1)
    return np.array([(part[0], part[np.argmin(squares[part])], part[-1]) for part in stretches])


def evenest(candidates: list[Array]) -> Places | None:
    """Which of its stretches, (n, 3) times each as of `places`, to take for each instant: the squares of the steps add up to least.

    Two instants alike on both sides of a turn of the loads are thereby one on each side, where any other rule would put both in
    one place. Steps don't go back, but within stretches that overlap, where order can't be told, and then they count more. None
    where no choice ascends.

    >>> at = lambda *times: np.array([(time, time, time) for time in times])
    >>> evenest([at(1.0), at(2.0, 4.0), at(2.0, 4.0), at(5.0)]).tolist()
    [0, 0, 1, 0]
    """
    cost, came = np.zeros(len(candidates[0])), []
    for before, here in pairwise(candidates):
        step = here[None, :, 1] - before[:, None, 1]
        square = np.where(step < 0, _BACK, 1.0) * step**2
        total = cost[:, None] + np.where(here[None, :, 2] >= before[:, None, 0], square, np.inf)
        came.append(np.argmin(total, axis=0))
        cost = np.min(total, axis=0)
    if not np.isfinite(cost).any():
        return None
    taken = [int(np.argmin(cost))]
    for back in reversed(came):
        taken.append(int(back[taken[-1]]))
    return np.array(taken[::-1])
