"""A rounded tip, h'' = 1/R up to x = b and 0 beyond, in closed form: what profiles of piecewise curvature are made of.

# notation: b half-length of the tip, a half-width, x >= 0, k^2 = a^2 - x^2, tau^2 = a^2 - b^2 (all lengths), E*/R = 1

Up to a = b this is Hertz. Differences of two tips, or of a parabola and a tip, are flats with rounded edges; sums with
coefficients > 0 keep all digits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Least r over b. Where it counts, |x - b| < 5e-25 b, r stands in (b - x) ln r alone, which is nothing.
_TINY = 1e-12


def tip_load(a: ArrayLike, b: ArrayLike) -> Array:
    """P = [b tau + a^2 arcsin(b/a)]/2, pi a^2/4 up to a = b.

    >>> round(float(tip_load(2.0, 3.0)), 12), round(float(tip_load(5.0, 3.0)), 12)
    (3.14159265359, 14.043763859916)
    """
    half, end = np.asarray(a, dtype=float), np.minimum(b, a)
    tau = np.sqrt((half - end) * (half + end))
    return (end * tau + half * half * np.arctan2(end, tau)) / 2


def tip_rise(square: Array, flat: Array) -> Array:
    """P - P(b) over b^2/2, (1 + t^2) arccot t + t - pi/2 with t = tau/b, from t^2 and F(t) = `flat` of `flat_law`.

    The same as pi/2 t^2 - F(t), which keeps its digits where t is small; the other does where t is large.

    >>> round(float(tip_rise(np.array(1.0), np.array(np.pi / 2 - 1))), 12)
    1.0
    """
    t = np.sqrt(square)
    return np.where(t < 1, np.pi / 2 * square - flat, (1 + square) * np.arctan2(1, t) + t - np.pi / 2)


def tip_stiffness(a: ArrayLike, b: ArrayLike) -> Array:
    """dP/da = a arcsin(b/a)."""
    half, end = np.asarray(a, dtype=float), np.minimum(b, a)
    return half * np.arctan2(end, np.sqrt((half - end) * (half + end)))


def tip_pressure(x: ArrayLike, a: ArrayLike, b: ArrayLike) -> Array:
    """p = [k arcsin(b/a) + b arsinh(A) - x arsinh(B)]/pi; A = tau/r, B = x tau/(r a) for x < b, A = k/r, B = b k/(r a) beyond.

    r^2 = |b^2 - x^2|; the arsinh are the artanh of the flat face (Ciavarella, Hills and Monno 1998), free of cancellation.

    >>> round(float(tip_pressure(3.0, 5.0, 3.0)), 12)  # x = b: [k arcsin(b/a) + b ln(a/b)]/pi
    1.307133597279
    """
    at, half, end = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (x, a, b)))
    end = np.minimum(end, half)
    k = np.sqrt(np.maximum((half - at) * (half + at), 0.0))
    tau = np.sqrt((half - end) * (half + end))
    r = np.maximum(np.sqrt(np.abs((end - at) * (end + at))), _TINY * end)
    safe = np.where(half > 0, half, 1.0)
    r = np.where(r > 0, r, 1.0)
    one = np.where(at < end, tau, k) / r
    other = np.where(at < end, at * tau, end * k) / (r * safe)
    return np.maximum(k * np.arctan2(end, tau) + end * np.arcsinh(one) - at * np.arcsinh(other), 0.0) * (at < half) / np.pi


def tip_log(a: ArrayLike, b: ArrayLike) -> Array:
    """int_0^a P/alpha d alpha = P/2 + b tau/2 - (b^2/2) arctan(tau/b).

    >>> round(float(tip_log(2.0, 3.0)) / np.pi, 12)  # pi a^2/8
    0.5
    """
    half, end = np.asarray(a, dtype=float), np.minimum(b, a)
    tau = np.sqrt((half - end) * (half + end))
    return tip_load(half, end) / 2 + (end * tau - end * end * np.arctan2(tau, end)) / 2
