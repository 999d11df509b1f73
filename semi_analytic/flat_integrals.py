"""Integrals over tau that normal contact of a flat face with rounded edges is made of: closed forms, and rules where they cancel.

# notation: as in `flat_rounded`; `inner` g^2 = 1 - x^^2, `edge` tau at which a = |x|, tau <= edge in spreads
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from semi_analytic.flat_law import inverse_load_function, load_function
from semi_analytic.quadrature import gauss, graded

Array = NDArray[np.float64]

NEARBY = 0.3
"""Share of P within which P_c is close to P: twelve of Gauss' nodes leave 6e-16 of Lam and of the drop of tau."""

# Tau (that of the edge, for spreads) up to which 24 of Gauss' nodes serve the integrands, singular at t = +-i: there the two rules
# differ by 5e-15.
_DEEP = 2.5
# Terms of the series of arctan t: what is left out at t = SHALLOW is 1e-16 of the first.
_TERMS = 14
# Share of tau^2 below which a difference is taken from the rise of F: three of Gauss' nodes leave 4e-16.
_CLOSE = 0.01


def _moment(tau: Array) -> Array:
    """arctan(t) F(t), an even function."""
    return np.arctan(tau) * load_function(tau)


def by_depth(smooth: Callable[..., Array], graded_rule: Callable[..., Array], place: Array, tau: Array, depth: Array) -> Array:
    """Gauss' rule while `depth` is moderate: the integrands are singular at t = +-i; the rule for singular ends beyond."""
    result, deep = np.empty(tau.shape), depth > _DEEP
    result[~deep] = smooth(place[~deep], tau[~deep])
    result[deep] = graded_rule(_moment, place[deep], tau[deep])
    return result


def pressure_moment_integral(inner: Array, tau: Array) -> Array:
    """int arctan(t) F(t) dr, r = sqrt(t^2 + g^2), from the least r on: the same integrand as a function of r^2 alone."""
    node, weight = gauss(24)
    least = np.sqrt(np.maximum(inner, 0.0))
    square = np.maximum(tau * tau + inner, 0.0)
    rise = np.where(inner > 0, tau * tau, square) / np.where(square > 0, np.sqrt(square) + least, 1.0) * (square > 0)
    above = rise[..., None] * node
    t = np.sqrt(above * (above + 2 * least[..., None]) + np.maximum(-inner, 0.0)[..., None])
    return rise * np.sum(weight * _moment(t), axis=-1)


def spread_moment_integral(edge: Array, tau: Array) -> Array:
    """int_0^tau 2 t arctan(t) F(t) arccosh(x^/sqrt(1 + t^2)) dt."""
    return _over_angle(_moment, edge, tau)


def pressure_in_closed_form(inner: Array, tau: Array) -> Array:
    """k arctan tau - artanh(tau/k) + x^ artanh(x^ tau/k) for x^ < 1, inverse arguments for x^ > 1, logarithms near 1."""
    root = np.sqrt(np.maximum(tau * tau + inner, 0.0))
    x = np.sqrt(1 - inner)
    # Where tau and k are close, their quotient has no digits left below 1; elsewhere the logarithms cancel.
    joined = np.abs(inner) < 0.2 * np.maximum(tau * tau, 1.0)
    safe = np.where(joined | (root == 0), 1.0, root)
    one = np.where(inner > 0, tau / safe, safe / np.where(tau > 0, tau, 1.0))
    other = np.where(inner > 0, x * tau / safe, safe / np.where(inner > 0, 1.0, x * tau))
    apart = np.arctanh(np.where(joined | (root == 0), 0.0, one)) - x * np.arctanh(np.where(joined | (root == 0), 0.0, other))
    offset = inner / (1 + x)
    size = np.where(inner == 0, 1.0, np.abs(inner))
    logs = np.log(root + tau) - x * np.log((root + x * tau) / np.sqrt(1 + tau * tau)) - offset / 2 * np.log(size)
    return np.where(root > 0, root * np.arctan(tau) - np.where(joined, logs, apart), 0.0)


def pressure_when_shallow(inner: Array, tau: Array) -> Array:
    """int t arctan(t)/sqrt(t^2 + g^2) dt up to tau <= SHALLOW, where its closed form cancels.

    Well inside the flat, g > tau, twelve of Gauss' nodes in t: the integrand is even, its nearest singularities are at t = +-i g.
    Beside and beyond the edge, term by term of arctan t = t - t^3/3 + ..., with r = sqrt(t^2 + g^2),

        I_k = int t^(2 k + 2)/r dt = [t^(2 k + 1) r - (2 k + 1) g^2 I_(k - 1)]/(2 k + 2),    I_0 = [t r - g^2 arsinh(t/g)]/2,

    and for g^2 < 0, from where the root vanishes, + |g|^2 arsinh(r/|g|).
    """
    result, inside = np.empty(tau.shape), inner > tau * tau
    node, share = gauss(12)
    t = tau[inside][..., None] * node
    quotient = t * np.arctan(t) / np.sqrt(t * t + inner[inside][..., None])
    result[inside] = tau[inside] * np.sum(share * quotient, axis=-1)
    t, square = tau[~inside], inner[~inside]
    edge = np.sqrt(np.abs(square))
    root = np.sqrt(np.where(square > 0, t * t + square, np.maximum((t - edge) * (t + edge), 0.0)))
    height = np.where(square > 0, t, root) / np.where(edge > 0, edge, 1.0)
    term = (t * root - square * np.arcsinh(height)) / 2
    power, total = t * root, np.where(root > 0, term, 0.0)
    for k in range(1, _TERMS):
        power = power * t * t
        term = (power - (2 * k + 1) * square * term) / (2 * k + 2)
        total = total + (-1) ** k / (2 * k + 1) * np.where(root > 0, term, 0.0)
    result[~inside] = total
    return result


def pressure_integral(weight: Callable[[Array], Array], inner: Array, tau: Array) -> Array:
    """int t weight(t) / sqrt(t^2 + g^2) dt up to tau; for g^2 < 0 over the root itself, which starts at 0."""
    edge = np.sqrt(np.maximum(-inner, 0.0))
    root = np.sqrt(np.maximum((tau - edge) * (tau + edge), 0.0))
    u, share = graded(0.0, np.where(inner > 0, tau, root))
    square = inner[..., None]
    t = np.where(square > 0, u, np.sqrt(u * u + np.maximum(-square, 0.0)))
    quotient = np.where(square > 0, u / np.sqrt(u * u + np.where(square > 0, square, 1.0)), 1.0)
    return np.sum(share * quotient * weight(t), axis=-1)


def spread_in_closed_form(edge: Array, tau: Array) -> Array:
    """F arccosh(x^/alpha) - x^ k arctan tau + (x^^2 + 1) arctan(x^ tau/k) - 2 x^ arctan(tau/k), here with k^2 = x^^2 - alpha^2."""
    x = np.sqrt(1 + edge * edge)
    root = np.sqrt(np.maximum((edge - tau) * (edge + tau), 0.0))
    reach = np.arcsinh(root / np.sqrt(1 + tau * tau))
    return (
        load_function(tau) * reach
        - x * root * np.arctan(tau)
        + (x * x + 1) * np.arctan2(x * tau, root)
        - 2 * x * np.arctan2(tau, root)
    )


def spread_when_shallow(edge: Array, tau: Array) -> Array:
    """The same integral where its closed form cancels."""
    return _over_angle(np.arctan, edge, tau)


def _over_angle(weight: Callable[[Array], Array], edge: Array, tau: Array) -> Array:
    """int_0^tau 2 t weight(t) arccosh(x^/sqrt(1 + t^2)) dt over t = edge sin(angle), smooth up to the edge, by Gauss' rule."""
    node, share = gauss(24)
    result, there = np.zeros(tau.shape), tau > 0
    end = edge[there]
    widest = np.arcsin(tau[there] / end)[:, None]
    angle = widest * node
    t, root = end[:, None] * np.sin(angle), end[:, None] * np.cos(angle)
    terms = 2 * t * weight(t) * np.arcsinh(root / np.sqrt(1 + t * t)) * root
    result[there] = widest[:, 0] * (terms @ share)
    return result


def spread_integral(weight: Callable[[Array], Array], edge: Array, tau: Array) -> Array:
    """int_0^tau 2 t weight(t) arccosh(x^/sqrt(1 + t^2)) dt."""
    t, share = graded(0.0, tau)
    # Both factors from the upper end, where the root vanishes.
    gap = np.maximum((edge[..., None] - t) * (edge[..., None] + t), 0.0)
    return np.sum(share * 2 * t * weight(t) * np.arcsinh(np.sqrt(gap / (1 + t * t))), axis=-1)


def square_gap(upper: Array, lower: Array, rise: Array) -> Array:
    """Difference of two tau^2, from the rise of F between them where they are close: F' = arctan tau."""
    direct = np.maximum(upper - lower, 0.0)
    mean = sum(w * np.arctan(np.sqrt(lower + direct * n)) for n, w in zip(*gauss(3), strict=True))
    return np.where(direct < _CLOSE * upper, rise / np.where(mean > 0, mean, np.inf), direct)


def drop_of_tau(upper: Array, load: Array, drop: Array) -> Array:
    """Drop of tau from the drop of F, free of cancellation: Newton's method for the drop of tau^2 where the two are close."""
    direct = upper - inverse_load_function(np.maximum(load - drop, 0.0))
    square = upper * upper
    small = np.where(drop < NEARBY * load, drop, 0.0)
    gap = small / np.where(upper > 0, np.arctan(upper), np.inf)
    node, weight = gauss(12)
    for _ in range(5):
        inside = np.maximum(square[..., None] - gap[..., None] * node, 0.0)
        fault = gap * np.sum(weight * np.arctan(np.sqrt(inside)), axis=-1) - small
        slope = np.arctan(np.sqrt(np.maximum(square - gap, 0.0)))
        gap = gap - fault / np.where(slope > 0, slope, np.inf)
    lower = np.sqrt(np.maximum(square - gap, 0.0))
    return np.where(drop < NEARBY * load, gap / np.where(upper > 0, upper + lower, 1.0), direct)


def log_area_nearby(upper: Array, drop: Array) -> Array:
    """Lam/unit = int t arctan(t) ln((1 + t^2)/(1 + tau_c^2)) dt by Gauss' rule, from tau and the drop to tau_c."""
    node, weight = gauss(12)
    above = drop[..., None] * node
    lower = (upper - drop)[..., None]
    t = lower + above
    integrand = t * np.arctan(t) * np.log1p(above * (t + lower) / (1 + lower * lower))
    return drop * np.sum(weight * integrand, axis=-1)
