"""Normal contact of a flat face with parabolic edges, in closed form, with the digits kept where the closed forms cancel.

# notation: b half-length of the flat, R edge radius, a half-width, P or eta normal load, tau = sqrt(a^2 - b^2)/b
#           (the paper's phi0 is arccot tau), unit = E* b^2/(2 R), x^ = |x|/b, alpha = a/b = sqrt(1 + tau^2),
#           g^2 = 1 - x^^2, k = sqrt(alpha^2 - x^^2), P_x load at which a = |x|

    P = unit F(tau),  F = (1 + tau^2) arctan tau - tau,  dF/d(tau^2) = arctan tau
    p = (E* b/(pi R)) int t arctan(t) / sqrt(t^2 + g^2) dt,  t from 0 or from where the root vanishes, to tau

The integral is elementary (Ciavarella, Hills and Monno 1998), but its terms cancel like tau^-2 as tau -> 0: there it is done by
quadrature.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike, NDArray

from semi_analytic.quadrature import graded

Array = NDArray[np.float64]

_SHALLOW = 0.3
_CLOSE = 0.01
_NEARBY = 0.3
_K = np.arange(1.0, 17.0)
_F_SERIES = -((-1.0) ** _K) * 2 / (4 * _K**2 - 1)
_G_SERIES = (-1.0) ** _K * (2 * _K - 2) / (4 * _K**2 - 1)
_GAUSS3 = np.polynomial.legendre.leggauss(3)
_GAUSS24 = np.polynomial.legendre.leggauss(24)
_GAUSS12 = np.polynomial.legendre.leggauss(12)


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
    shallow = tau < _SHALLOW
    if not np.any(shallow):
        return closed
    small = np.minimum(tau, _SHALLOW)
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


@dataclass(frozen=True)
class FlatRoundedContact:
    """Two half-planes pressed together by a flat face of half-length b with edges of radius R. Methods as in `Contact`.

    >>> contact = FlatRoundedContact(modulus=2.0, radius=1.0, flat_half_length=1.0, datum_length=1.0)
    >>> round(float(contact.load(np.sqrt(2.0))), 12)  # tau = 1
    0.570796326795
    """

    modulus: float
    radius: float
    flat_half_length: float
    datum_length: float

    @property
    def unit(self) -> float:
        """E* b^2 / (2 R), the unit of load."""
        return self.modulus * self.flat_half_length**2 / (2 * self.radius)

    @property
    def stress(self) -> float:
        """E* b / (pi R), the unit of pressure."""
        return self.modulus * self.flat_half_length / (np.pi * self.radius)

    def tau(self, load: ArrayLike) -> Array:
        """sqrt(a^2 - b^2)/b from the load."""
        return inverse_load_function(np.asarray(load, dtype=float) / self.unit)

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) = b sqrt(1 + tau^2) [length]; b for P = 0."""
        return self.flat_half_length * np.sqrt(1 + np.square(self.tau(load)))

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]; 0 for a < b."""
        return self.unit * load_function(self._edge_tau(half_width))

    def _edge_tau(self, x: ArrayLike) -> Array:
        return np.sqrt(np.maximum(-self._inner(x), 0.0))

    def _inner(self, x: ArrayLike) -> Array:
        """g^2 = 1 - (x/b)^2."""
        ratio = np.abs(np.asarray(x, dtype=float)) / self.flat_half_length
        return (1 - ratio) * (1 + ratio)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        inner, tau = np.broadcast_arrays(self._inner(x), self.tau(load))
        shallow = tau < _SHALLOW
        result = np.zeros(tau.shape)
        result[~shallow] = _pressure_in_closed_form(inner[~shallow], tau[~shallow])
        result[shallow] = _pressure_integral(np.arctan, inner[shallow], tau[shallow])
        return self.stress * result

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load], by quadrature."""
        inner, tau = np.broadcast_arrays(self._inner(x), self.tau(load))
        return self.stress * self.unit * _pressure_integral(lambda t: np.arctan(t) * load_function(t), inner, tau)

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]."""
        edge = self._edge_tau(x)
        edge, tau = np.broadcast_arrays(edge, np.minimum(edge, self.tau(load)))
        shallow = tau < _SHALLOW
        result = np.zeros(tau.shape)
        result[~shallow] = _spread_in_closed_form(edge[~shallow], tau[~shallow])
        result[shallow] = _spread_when_shallow(edge[shallow], tau[shallow])
        return self.unit * result

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x), by quadrature."""
        edge = self._edge_tau(x)
        edge, tau = np.broadcast_arrays(edge, np.minimum(edge, self.tau(load)))
        return self.unit**2 * _spread_integral(lambda t: np.arctan(t) * load_function(t), edge, tau)

    def reach(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) = arsinh(sqrt(x^2 - a^2)/a), from eta and P_x - eta >= 0."""
        upper, lower = np.square(self._edge_tau(x)), np.square(self.tau(load))
        gap = _square_gap(upper, lower, np.asarray(excess, dtype=float) / self.unit)
        return np.arcsinh(np.sqrt(gap / (1 + lower)))

    def root_quotient(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """sqrt((eta - P_x)/(a(eta)^2 - x^2)), from eta and eta - P_x > 0."""
        inner, upper = self._inner(x), np.square(self.tau(load))
        rise = np.asarray(excess, dtype=float) / self.unit
        gap = np.where(inner > 0, upper + inner, _square_gap(upper, np.maximum(-inner, 0.0), rise))
        return np.sqrt(self.unit * rise / np.where(gap > 0, gap, np.inf)) / self.flat_half_length

    def log_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P))."""
        return np.log(2 * self.datum_length / self.half_width(load))

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta = P ln(2 L/a) + unit G [force per thickness]."""
        return np.asarray(load, dtype=float) * self.log_ratio(load) + self.unit * log_function(self.tau(load))

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta = (P^2/2) ln(2 L/a) + (unit^2/2) int_0^tau F^2 t/(1 + t^2) dt, by quadrature."""
        t, weight = graded(0.0, self.tau(load))
        rest = np.sum(weight * load_function(t) ** 2 * t / (1 + t * t), axis=-1)
        return np.square(np.asarray(load, dtype=float)) / 2 * self.log_ratio(load) + self.unit**2 / 2 * rest

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) from P and P - P_c: closed form, or quadrature over tau^2 where P_c is close to P."""
        p, d = np.broadcast_arrays(np.asarray(load, dtype=float) / self.unit, np.asarray(slipped, dtype=float) / self.unit)
        upper = inverse_load_function(p)
        drop = _drop_of_tau(upper, p, d)
        lower = upper - drop
        ratio = np.log1p(drop * (upper + lower) / (1 + lower * lower)) / 2
        apart = load_function(upper) * ratio - (log_function(upper) - log_function(lower))
        return self.unit * np.where((d < _NEARBY * p) | (upper < 1), _log_area_nearby(upper, drop), apart)


def _pressure_in_closed_form(inner: Array, tau: Array) -> Array:
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


def _pressure_integral(weight: Callable[[Array], Array], inner: Array, tau: Array) -> Array:
    """int t weight(t) / sqrt(t^2 + g^2) dt up to tau; for g^2 < 0 over the root itself, which starts at 0."""
    edge = np.sqrt(np.maximum(-inner, 0.0))
    root = np.sqrt(np.maximum((tau - edge) * (tau + edge), 0.0))
    u, share = graded(0.0, np.where(inner > 0, tau, root))
    square = inner[..., None]
    t = np.where(square > 0, u, np.sqrt(u * u + np.maximum(-square, 0.0)))
    quotient = np.where(square > 0, u / np.sqrt(u * u + np.where(square > 0, square, 1.0)), 1.0)
    return np.sum(share * quotient * weight(t), axis=-1)


def _spread_in_closed_form(edge: Array, tau: Array) -> Array:
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


def _spread_when_shallow(edge: Array, tau: Array) -> Array:
    """The same integral over t = edge sin(angle), smooth up to the edge, by Gauss' rule."""
    node, weight = _GAUSS24
    widest = np.arcsin(tau / np.where(edge > 0, edge, 1.0))[..., None] / 2
    angle = widest * (1 + node)
    t = edge[..., None] * np.sin(angle)
    root = edge[..., None] * np.cos(angle)
    return np.sum(widest * weight * 2 * t * np.arctan(t) * np.arcsinh(root / np.sqrt(1 + t * t)) * root, axis=-1)


def _spread_integral(weight: Callable[[Array], Array], edge: Array, tau: Array) -> Array:
    """int_0^tau 2 t weight(t) arccosh(x^/sqrt(1 + t^2)) dt."""
    t, share = graded(0.0, tau)
    # Both factors from the upper end, where the root vanishes.
    gap = np.maximum((edge[..., None] - t) * (edge[..., None] + t), 0.0)
    return np.sum(share * 2 * t * weight(t) * np.arcsinh(np.sqrt(gap / (1 + t * t))), axis=-1)


def _square_gap(upper: Array, lower: Array, rise: Array) -> Array:
    """Difference of two tau^2, from the rise of F between them where they are close: F' = arctan tau."""
    direct = np.maximum(upper - lower, 0.0)
    node, weight = _GAUSS3
    mean = sum(w / 2 * np.arctan(np.sqrt(lower + direct * (1 + n) / 2)) for n, w in zip(node, weight, strict=True))
    return np.where(direct < _CLOSE * upper, rise / np.where(mean > 0, mean, np.inf), direct)


def _drop_of_tau(upper: Array, load: Array, drop: Array) -> Array:
    """Drop of tau from the drop of F, free of cancellation: Newton's method for the drop of tau^2 where the two are close."""
    direct = upper - inverse_load_function(np.maximum(load - drop, 0.0))
    square = upper * upper
    small = np.where(drop < _NEARBY * load, drop, 0.0)
    gap = small / np.where(upper > 0, np.arctan(upper), np.inf)
    node, weight = _GAUSS12
    for _ in range(5):
        inside = np.maximum(square[..., None] - gap[..., None] * (1 + node) / 2, 0.0)
        fault = gap / 2 * np.sum(weight * np.arctan(np.sqrt(inside)), axis=-1) - small
        slope = np.arctan(np.sqrt(np.maximum(square - gap, 0.0)))
        gap = gap - fault / np.where(slope > 0, slope, np.inf)
    lower = np.sqrt(np.maximum(square - gap, 0.0))
    return np.where(drop < _NEARBY * load, gap / np.where(upper > 0, upper + lower, 1.0), direct)


def _log_area_nearby(upper: Array, drop: Array) -> Array:
    """Lam/unit = int t arctan(t) ln((1 + t^2)/(1 + tau_c^2)) dt by Gauss' rule, from tau and the drop to tau_c."""
    node, weight = _GAUSS12
    above = drop[..., None] * (1 + node) / 2
    lower = (upper - drop)[..., None]
    t = lower + above
    integrand = t * np.arctan(t) * np.log1p(above * (t + lower) / (1 + lower * lower))
    return drop / 2 * np.sum(weight * integrand, axis=-1)
