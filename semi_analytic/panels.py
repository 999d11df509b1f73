"""Rules for singular ends on panels between given marks, with the distances from both ends of the range free of cancellation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semi_analytic.quadrature import ROOTS, Rule

Array = NDArray[np.float64]

CHUNK = 4_000_000
"""Nodes that are held at a time."""


class Nodes(NamedTuple):
    """Nodes of panels between `begin` and `end`, distances from both without cancellation, weights: (..., panels, nodes)."""

    at: Array
    above: Array
    below: Array
    weight: Array


def panels(begin: ArrayLike, end: ArrayLike, breaks: Iterable[ArrayLike] = (), rule: Rule = ROOTS) -> Nodes:
    """A rule for singular ends on [begin, end], cut at those of `breaks` (ascending, arrays like `end`) that lie inside."""
    first, last = np.broadcast_arrays(np.asarray(begin, dtype=float), np.asarray(end, dtype=float))
    inside = [b for b in breaks if np.any((first < b) & (b < last))]
    marks = [first, *(np.clip(b, first, last) for b in inside), last]
    low, high = np.stack(marks[:-1], axis=-1)[..., None], np.stack(marks[1:], axis=-1)[..., None]
    length = high - low
    up, down = length * rule.up, length * rule.down
    above = (low - first[..., None, None]) + up
    below = (last[..., None, None] - high) + down
    return Nodes(np.where(rule.up < 0.5, low + up, high - down), above, below, length * rule.share)


def in_chunks(function: Callable[[Array, Array], Array], one: ArrayLike, other: ArrayLike, nodes: int) -> Array:
    """The function over broadcast arguments, a bounded number of nodes at a time."""
    first, second = np.broadcast_arrays(np.asarray(one, dtype=float), np.asarray(other, dtype=float))
    shape, count = first.shape, max(CHUNK // max(nodes, 1), 1)
    if first.size <= count:
        return np.asarray(function(first, second))
    flat, flat_too = first.ravel(), second.ravel()
    parts = [function(flat[k : k + count], flat_too[k : k + count]) for k in range(0, flat.size, count)]
    return np.concatenate(parts).reshape(shape)
