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

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semi_analytic.flat_integrals import (
    NEARBY,
    by_depth,
    drop_of_tau,
    log_area_nearby,
    pressure_in_closed_form,
    pressure_integral,
    pressure_moment_integral,
    pressure_when_shallow,
    spread_in_closed_form,
    spread_integral,
    spread_moment_integral,
    spread_when_shallow,
    square_gap,
)
from semi_analytic.flat_law import SHALLOW, inverse_load_function, load_function, log_function
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]


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
        shallow = tau < SHALLOW
        result = np.zeros(tau.shape)
        result[~shallow] = pressure_in_closed_form(inner[~shallow], tau[~shallow])
        result[shallow] = pressure_when_shallow(inner[shallow], tau[shallow])
        return self.stress * result

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load], by quadrature."""
        inner, tau = np.broadcast_arrays(self._inner(x), self.tau(load))
        return self.stress * self.unit * by_depth(pressure_moment_integral, pressure_integral, inner, tau, tau)

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]."""
        edge = self._edge_tau(x)
        edge, tau = np.broadcast_arrays(edge, np.minimum(edge, self.tau(load)))
        shallow = tau < SHALLOW
        result = np.zeros(tau.shape)
        result[~shallow] = spread_in_closed_form(edge[~shallow], tau[~shallow])
        result[shallow] = spread_when_shallow(edge[shallow], tau[shallow])
        return self.unit * result

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x), by quadrature."""
        edge = self._edge_tau(x)
        edge, tau = np.broadcast_arrays(edge, np.minimum(edge, self.tau(load)))
        return self.unit**2 * by_depth(spread_moment_integral, spread_integral, edge, tau, edge)

    def reach(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) = arsinh(sqrt(x^2 - a^2)/a), from eta and P_x - eta >= 0."""
        upper, lower = np.square(self._edge_tau(x)), np.square(self.tau(load))
        gap = square_gap(upper, lower, np.asarray(excess, dtype=float) / self.unit)
        return np.arcsinh(np.sqrt(gap / (1 + lower)))

    def root_quotient(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """sqrt((eta - P_x)/(a(eta)^2 - x^2)), from eta and eta - P_x > 0."""
        inner, upper = self._inner(x), np.square(self.tau(load))
        rise = np.asarray(excess, dtype=float) / self.unit
        gap = np.where(inner > 0, upper + inner, square_gap(upper, np.maximum(-inner, 0.0), rise))
        return np.sqrt(self.unit * rise / np.where(gap > 0, gap, np.inf)) / self.flat_half_length

    def log_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P)) = ln(2 L/b) - ln(1 + tau^2)/2, so that its change keeps its digits where a hardly leaves b."""
        return np.log(2 * self.datum_length / self.flat_half_length) - np.log1p(np.square(self.tau(load))) / 2

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
        drop = drop_of_tau(upper, p, d)
        lower = upper - drop
        ratio = np.log1p(drop * (upper + lower) / (1 + lower * lower)) / 2
        apart = load_function(upper) * ratio - (log_function(upper) - log_function(lower))
        return self.unit * np.where((d < NEARBY * p) | (upper < 1), log_area_nearby(upper, drop), apart)
