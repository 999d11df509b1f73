"""Quadrature rules for singular ends on panels between given marks, with the distances from both ends free of cancellation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_STEP = 0.375
CHUNK = 4_000_000
"""Nodes that are held at a time."""


class Rule(NamedTuple):
    """Trapezoidal rule in s of 1/(1 + exp(-s)) on [0, 1]: distances from both ends, weights."""

    up: Array
    down: Array
    share: Array


def _rule(low: float, high: float) -> Rule:
    s = np.arange(low, high + _STEP / 2, _STEP)
    up, down = 1 / (1 + np.exp(-s)), 1 / (1 + np.exp(s))
    return Rule(up, down, _STEP * up * down)


ROOTS = _rule(-36.0, 36.0)
"""For roots and logarithms at the ends."""

INVERSE_ROOT = _rule(-75.0, 36.0)
"""For an inverse root at the lower end too."""


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
