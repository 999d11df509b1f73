"""Load and logarithm of a flat face with parabolic edges as functions of tau = sqrt(a^2 - b^2)/b, and the inverse, to rounding."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SHALLOW = 0.3
"""Below this tau closed forms cancel."""

_K = np.arange(1.0, 17.0)
_F_SERIES = -((-1.0) ** _K) * 2 / (4 * _K**2 - 1)
_G_SERIES = (-1.0) ** _K * (2 * _K - 2) / (4 * _K**2 - 1)


def load_function(tau: ArrayLike) -> Array:
    """F(tau) = (1 + tau^2) arctan tau - tau = 2 tau^3/3 - 2 tau^5/15 + ... to full relative accuracy.

    >>> round(float(load_function(1.0)), 12)  # pi/2 - 1
    0.570796326795
    """
    t = np.asarray(tau, dtype=float)
    return _joined(t, _F_SERIES, (1 + t * t) * np.arctan(t) - t)


def log_function(tau: ArrayLike) -> Array:
    """G(tau) = F/2 - tau + arctan tau = int_0^tau F t/(1 + t^2) dt = 2 tau^5/15 - ... to full relative accuracy."""
    t = np.asarray(tau, dtype=float)
    return _joined(t, _G_SERIES, load_function(t) / 2 - t + np.arctan(t))


def _joined(tau: Array, coefficients: Array, closed: Array) -> Array:
    """The closed form, and the series of coefficients[k] tau^(2 k + 3) where tau is small."""
    shallow = tau < SHALLOW
    if not np.any(shallow):
        return closed
    small = np.minimum(tau, SHALLOW)
    square, total = small * small, np.full(np.shape(tau), coefficients[-1])
    for coefficient in coefficients[-2::-1].tolist():
        total = total * square + coefficient
    return np.where(shallow, total * small * square, closed)


def inverse_load_function(value: ArrayLike) -> Array:
    """Tau of F(tau) = value >= 0, to rounding: a fit good to 5e-7, then one step of Halley's method, which cubes that.

    >>> round(float(inverse_load_function(np.pi / 2 - 1)), 12)
    1.0
    """
    y = np.asarray(value, dtype=float)
    small, wide = np.cbrt(1.5 * y), np.sqrt(y * (2 / np.pi))
    part = np.minimum(small, _SMALL_END)
    inverse = 1 / np.maximum(wide, 1 / _WIDE_END)
    tau = np.where(y < _SPLIT, small * polyval(part * part, _SMALL_FIT), wide * polyval(inverse, _WIDE_FIT))
    angle = np.arctan(tau)
    fault = _joined(tau, _F_SERIES, (1 + tau * tau) * angle - tau) - y
    slope, bend = 2 * tau * angle, 2 * (angle + tau / (1 + tau * tau))
    below = 2 * slope * slope - fault * bend
    return tau - 2 * fault * slope / np.where(below > 0, below, 1.0)


def _fits() -> tuple[Array, Array]:
    """Polynomials of tau/(1.5 y)^(1/3) in (1.5 y)^(2/3) below the split, of tau/sqrt(2 y/pi) in the inverse of that root above."""
    place = (1 - np.cos(np.pi * np.arange(401) / 400)) / 2
    inner = 1e-3 + place * (_SMALL_TAU - 1e-3)
    square = np.cbrt(1.5 * load_function(inner)) ** 2
    outer = _SMALL_TAU / (1e-6 + (1 - 1e-6) * place)
    wide = np.sqrt(load_function(outer) * (2 / np.pi))
    fits = (Polynomial.fit(square, inner / np.sqrt(square), 7), Polynomial.fit(1 / wide, outer / wide, 9))
    return tuple(fit.convert().coef for fit in fits)  # type: ignore[return-value]


_SMALL_TAU = 1.4
_SPLIT = float(load_function(_SMALL_TAU))
_SMALL_END, _WIDE_END = float(np.cbrt(1.5 * _SPLIT)), float(np.sqrt(np.pi / (2 * _SPLIT)))
_SMALL_FIT, _WIDE_FIT = _fits()
