"""Which Gauss rule a steady ellipse needs, from where its integrands stop being analytic.

In J-M and E-G the logarithm is singular where P_c = 0, at s = +-2 i arsinh(sqrt(P_T/u)) from M, and with v from G. Where P = 0 it
is so +-2 i arsinh(sqrt(P_min/(2 P1))) beside t = pi, at s = pi - t_E in E-G and s = t_E in I-J; the mirror images in J-M and of
I-J are farther away. Gauss' rule of n nodes leaves about rho^(-2 n), rho + 1/rho being the sum of the distances of the nearest
singularity from the ends of the interval [-1, 1]. Twelve at least, since nearly without slip the integrand is a cube of sines.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semi_analytic.quadrature import gauss, graded

Array = NDArray[np.float64]

_DIGITS = 30.0
_COUNTS = (12, 14, 16, 18, 20, 23, 26, 32, 42)


RULES: tuple[tuple[Array, Array], ...] = (*(gauss(count) for count in _COUNTS), graded(0.0, 1.0))
"""Nodes and weights on [0, 1], each symmetric about the middle; the last one for singularities at the ends."""

_LEAST = np.cosh(_DIGITS / (2 * np.array(_COUNTS)))[:, None]


def rule_of(mean: Array, amplitude: Array, u: Array, v: Array, start: Array, turn: Array, permanent: Array) -> NDArray[np.uint8]:
    """Index in `RULES` of the least rule that leaves exp(-30), arrays (m,): P0, P1, u, v, t_E, D, P_T."""
    wide, rest = np.maximum(turn, _TINY), np.maximum(math.pi - turn, _TINY)
    half = _half_sum(-1.0, 2 * _height(permanent, np.maximum(u, v)) / wide)
    high = 2 * _height(mean - amplitude, 2 * amplitude)
    np.minimum(half, _half_sum(2 * (math.pi - start) / wide - 1, high / wide), out=half)
    np.minimum(half, _half_sum(2 * start / rest - 1, high / rest), out=half)
    return np.sum(half < _LEAST, axis=0, dtype=np.uint8)


_TINY = 1e-100


def _height(load: Array, size: Array) -> Array:
    """2 arsinh(sqrt(load/size))."""
    return 2 * np.arcsinh(np.sqrt(load / np.maximum(size, _TINY)))


def _half_sum(centre: Array | float, height: Array) -> Array:
    """Half the sum of the distances of centre + i height from -1 and 1."""
    square = height * height
    return (np.sqrt(np.square(centre - 1) + square) + np.sqrt(np.square(centre + 1) + square)) / 2
