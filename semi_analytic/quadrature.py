"""One rule for integrands whose singularities lie at the ends of the range or close to them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_RANGE = 36.0


def _rule(step: float) -> tuple[Array, Array, Array]:
    """Places s, distances to the nearer end and weights on [0, 1]."""
    s = np.arange(-_RANGE, _RANGE + step / 2, step)
    near = 1 / (1 + np.exp(np.abs(s)))
    return s, near, step * near * (1 - near)


_S, _NEAR, _WEIGHT = _rule(0.375)

NODES = len(_S)
"""Nodes of the rule."""


def graded(begin: ArrayLike, end: ArrayLike) -> tuple[Array, Array]:
    """Nodes and weights on [begin, end], a new last axis: trapezoidal rule in s of begin + (end - begin)/(1 + exp(-s)).

    A singularity beyond an end lies on the line Im s = pi, however near the end it is, so that roots and logarithms at the ends and
    next to them cost nothing: about 1e-14 of the largest value of the integrand times the range.

    >>> nodes, weights = graded(0.0, 4.0)
    >>> round(float(np.sum(weights * np.sqrt(nodes))), 12)  # 2/3 4^(3/2)
    5.333333333333
    """
    first, last = np.asarray(begin, dtype=float)[..., None], np.asarray(end, dtype=float)[..., None]
    length = last - first
    return np.where(_S < 0, first + length * _NEAR, last - length * _NEAR), length * _WEIGHT
