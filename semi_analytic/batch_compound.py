"""Compound curvature and wedges with a rounded tip, their parameters arrays; Lam in closed form, to full relative accuracy.

# notation: as in `compound`; P_b = P(b), t = tau, f = dP/d(tau^2)

A step from P down to P_c across the corner is one outside and one inside, where all is Hertz:

    Lam(P, P_c) = Lam(P, P_b) + (P - P_b) ln(b/c) + Lam(P_b, P_c)
    outside: P ln(a/c) less the difference of int P/alpha d alpha, or int 2 t f(t) ln(alpha/c) dt where P_c is close to P
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semi_analytic.flat_law import load_function, log_function
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.hertz import log_excess
from semi_analytic.pile import rising_root
from semi_analytic.quadrature import gauss
from semi_analytic.tip import tip_load, tip_log, tip_pressure, tip_rise

Array = NDArray[np.float64]

# Share of P within which P_c is close to P: twelve of Gauss' nodes leave 9e-15 of Lam.
_NEARBY = 0.3
_NODES, _WEIGHTS = gauss(12)


@dataclass(frozen=True, eq=False)
class CompoundContacts:
    """The contacts of many profiles of two curvatures: E*, R1, R2 and b are numbers or arrays that broadcast with the arguments.

    R2 is infinite for all (wedges) or for none. The methods of `Contact` that batches use.
    """

    modulus: float
    inner_radius: Array | float
    outer_radius: Array | float
    inner_half_length: Array | float

    @property
    def tip(self) -> Array | float:
        """E*/R1 [stress per length]."""
        return self.modulus / self.inner_radius

    @property
    def edge(self) -> FlatRoundedContact | None:
        """What lies outside; None if all have straight flanks."""
        if np.all(np.isinf(self.outer_radius)):
            return None
        return FlatRoundedContact(self.modulus, self.outer_radius, self.inner_half_length, 1.0)  # type: ignore[arg-type]

    def tau(self, load: ArrayLike) -> Array:
        """sqrt(a^2 - b^2)/b from the load, 0 up to a = b."""
        square = np.square(self.inner_half_length) / 2
        inner, outer = self.tip * square, self.modulus / self.outer_radius * square
        rest = np.maximum(np.asarray(load, dtype=float) - self.corner_loads[0], 0.0)

        def above(square: Array) -> Array:
            # P - P(b)
            flat = load_function(np.sqrt(square))
            return inner * tip_rise(square, flat) + outer * flat

        guess = rest / (inner + outer) + np.where(outer > 0, 0.0, np.square(rest / (2 * inner)))
        return np.sqrt(rising_root(above, lambda square: self.rate(np.sqrt(square)), rest, guess))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]."""
        p, b = np.asarray(load, dtype=float), self.inner_half_length
        inside = np.minimum(np.sqrt(4 * p / (np.pi * self.tip)), b)
        return np.where(p <= self.corner_loads[0], inside, b * np.sqrt(1 + np.square(self.tau(p))))

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]."""
        half = np.abs(np.asarray(half_width, dtype=float))
        total = self.tip * tip_load(half, self.inner_half_length)
        return total if self.edge is None else total + self.edge.load(half)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        total = self.tip * tip_pressure(np.abs(x), self.half_width(load), self.inner_half_length)
        if self.edge is None:
            return total
        return total + self.edge.pressure(x, self.edge.unit * load_function(self.tau(load)))

    @property
    def corner_loads(self) -> Array:
        """P_b, a leading axis for the corners."""
        return np.asarray(self.tip * tip_load(self.inner_half_length, self.inner_half_length))[None]

    def rate(self, tau: Array) -> Array:
        """f = dP/d(tau^2) [force per thickness]."""
        square = np.square(self.inner_half_length) / 2
        return square * (self.tip * np.arctan2(1.0, tau) + self.modulus / self.outer_radius * np.arctan(tau))

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) from P and P - P_c."""
        p, d = np.broadcast_arrays(np.asarray(load, dtype=float), np.asarray(slipped, dtype=float))
        corner = self.corner_loads[0]
        outside = np.minimum(d, np.maximum(p - corner, 0.0))
        inside = d - outside
        start = np.minimum(p, corner)
        part = inside / np.where(start > 0, start, 1.0)
        excess = log_excess(part)
        # ln(b/c), where the front is inside
        log = (excess + part) / 2
        return start / 2 * excess + outside * log + self._outside(np.maximum(p, corner), outside)

    def _outside(self, load: Array, slipped: Array) -> Array:
        """Lam from P >= P_b to P - slipped >= P_b."""
        b, upper = self.inner_half_length, self.tau(load)
        drop = self._drop_of_tau(upper, load, slipped)
        lower = upper - drop
        log = np.log1p(drop * (upper + lower) / (1 + lower * lower)) / 2
        one, other = (self.tip * tip_log(b * np.sqrt(1 + t * t), b) for t in (upper, lower))
        far = load * log - (one - other)
        if self.edge is not None:
            far = far - self.edge.unit * (log_function(upper) - log_function(lower))
        near = np.zeros(np.shape(far))
        for node, weight in zip(_NODES, _WEIGHTS, strict=True):
            above = drop * node
            t = lower + above
            near += weight * 2 * t * self.rate(t) * np.log1p(above * (t + lower) / (1 + lower * lower)) / 2
        return np.where(slipped < _NEARBY * load, near * drop, far)

    def _drop_of_tau(self, upper: Array, load: Array, slipped: Array) -> Array:
        """Drop of tau from a drop of P outside the corner, free of cancellation: Newton's method where the two are close."""
        direct = upper - self.tau(load - slipped)
        # From the corner up P - P_b is about 2 f tau^2, so that a drop to the corner is one of tau as a whole.
        drop, small = direct, np.where(slipped < _NEARBY * load, slipped, 0.0)
        for _ in range(3):
            fall = sum(
                weight * 2 * (upper - drop * node) * self.rate(upper - drop * node)
                for node, weight in zip(_NODES, _WEIGHTS, strict=True)
            )
            lower = upper - drop
            slope = 2 * lower * self.rate(lower)
            drop = np.clip(drop - (drop * fall - small) / np.where(slope > 0, slope, np.inf), 0.0, upper)
        return np.where(slipped < _NEARBY * load, drop, direct)

    def reach(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) from eta and P_x - eta >= 0; 0 is returned for eta = 0."""
        del x
        rise, p = np.broadcast_arrays(np.asarray(excess, dtype=float), np.asarray(load, dtype=float))
        corner, square = self.corner_loads[0], np.square(self.inner_half_length)
        inside = np.minimum(rise, np.maximum(corner - p, 0.0))
        top = np.maximum(p + rise, corner)
        upper = self.tau(top)
        drop = self._drop_of_tau(upper, top, rise - inside)
        gap = square * (inside / corner + drop * (2 * upper - drop))
        half = self.half_width(p)
        return np.arcsinh(np.sqrt(gap) / np.where(half > 0, half, np.inf))
