"""Normal contact of the power law h = rise (|x|/length)^n, n >= 1 real, by beta and hypergeometric functions.

# notation: a half-width, alpha half-width of a punch in the pile, P or eta normal load, P_x load at which a = |x|, L datum length,
#           xi = |x|/a, W^2 = 1 - xi^2, zeta = min(a, |x|)/|x|

    P = K a^n,                                K = E* n (rise/length^n) (sqrt(pi)/2) Gamma((n+1)/2)/Gamma(n/2+1)
    p = (n K/pi) a^(n-1) J_n(xi),             J_n = int_xi^1 t^(n-1)/sqrt(t^2 - xi^2) dt = W 2F1(1-n/2, 1; 3/2; W^2)
    S = P arccosh(|x|/a) + K |x|^n I_n(zeta), I_n = int_0^zeta t^(n-1)/sqrt(1 - t^2) dt = B(zeta^2; n/2, 1/2)/2

A load in front makes the power 2n instead of n.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from semi_analytic.hertz import log_excess
from semi_analytic.panels import in_chunks, panels
from semi_analytic.quadrature import INVERSE_ROOT

Array = NDArray[np.float64]

# Share of a within which p is integrated, and within which its leading terms are taken: the next one is xi^2 of them.
_INNER = 0.1
_MIDDLE = 1e-11
# 1 - (x/a)^2 below which the root of what is left keeps more digits than x/a: ten times eps beyond it.
_NEAR = 0.01
# Share of P that is beyond P_x from which on 1 - (x/a)^2 keeps more digits by x than by the loads.
_INSIDE = 0.9


def load_factor(exponent: float) -> float:
    """int_0^(pi/2) sin(theta)^n d theta = (sqrt(pi)/2) Gamma((n+1)/2)/Gamma(n/2+1).

    >>> round(load_factor(1.0), 15), round(load_factor(2.0), 15)  # 1 and pi/4
    (1.0, 0.785398163397448)
    """
    return float(scipy.special.beta((exponent + 1) / 2, 0.5)) / 2


def pressure_function(exponent: float, ratio: ArrayLike) -> Array:
    """J_n(xi) = int_xi^1 t^(n-1)/sqrt(t^2 - xi^2) dt for xi <= 1, 0 beyond; infinite for n = 1 and xi = 0.

    >>> round(float(pressure_function(2.0, 0.6)), 15)  # sqrt(1 - xi^2)
    0.8
    """
    xi = np.minimum(np.asarray(ratio, dtype=float), 1.0)
    root = np.sqrt((1 - xi) * (1 + xi))
    if exponent == 1:
        with np.errstate(divide="ignore"):
            return np.arcsinh(root / xi)
    # Near the middle the hypergeometric function hangs on 1 - xi^2, which has forgotten xi.
    inner = xi < (_INNER if exponent < 4 else 0.0)
    result = np.asarray(root * scipy.special.hyp2f1(1 - exponent / 2, 1.0, 1.5, np.where(inner, 0.5, root * root)))
    if np.any(inner):
        result[inner] = in_chunks(lambda at, _: _pressure_inside(exponent, at), xi[inner], 0.0, len(INVERSE_ROOT.up))
    return result


def _pressure_inside(exponent: float, xi: Array) -> Array:
    """By quadrature, and in the very middle by the two leading terms: 1/(n-1), and what stands before xi^(n-1)."""
    first = np.maximum(xi, _MIDDLE)[..., None, None]
    node = panels(first[..., 0, 0], 1.0, (), INVERSE_ROOT)
    root = np.sqrt(node.above * (node.at + first))
    whole = np.sum(node.weight * node.at ** (exponent - 1) / root, axis=(-2, -1))
    second = scipy.special.gamma((1 - exponent) / 2) * scipy.special.rgamma(1 - exponent / 2)
    other = np.sqrt(np.pi) / 2 * second if exponent < 3 else 0.0
    return np.where(xi < _MIDDLE, 1 / (exponent - 1) + other * xi ** (exponent - 1), whole)


def spread_function(exponent: float, ratio: ArrayLike, rest: ArrayLike) -> Array:
    """I_n(zeta) = int_0^zeta t^(n-1)/sqrt(1 - t^2) dt, from zeta and from 1 - zeta^2 = `rest`, of which it is a root near the edge.

    >>> round(float(spread_function(2.0, 0.6, 0.64)), 15)  # 1 - sqrt(1 - zeta^2)
    0.2
    """
    zeta, other = np.broadcast_arrays(np.asarray(ratio, dtype=float), np.asarray(rest, dtype=float))
    share = np.asarray(scipy.special.betainc(exponent / 2, 0.5, zeta * zeta))
    near = other < _NEAR  # there alone: it takes ten times as long
    share[near] = scipy.special.betaincc(0.5, exponent / 2, other[near])
    return np.asarray(share * (scipy.special.beta(exponent / 2, 0.5) / 2))


@dataclass(frozen=True)
class PowerLawContact:
    """Two half-planes pressed together by a power law. Methods as in `Contact`.

    >>> contact = PowerLawContact(modulus=100.0, exponent=2.0, length=1.0, rise=0.5, datum_length=1.0)  # Hertz with R = 1
    >>> round(float(contact.half_width(25 * np.pi)), 12)
    1.0
    """

    modulus: float
    exponent: float
    length: float
    rise: float
    datum_length: float

    @property
    def factor(self) -> float:
        """P for a = length [force per thickness]."""
        return self.modulus * self.exponent * self.rise * load_factor(self.exponent)

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]."""
        return self.length * np.power(np.asarray(load, dtype=float) / self.factor, 1 / self.exponent)

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]."""
        return self.factor * np.power(np.abs(np.asarray(half_width, dtype=float)) / self.length, self.exponent)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact; for n = 1 infinite at the tip."""
        return self._pressure(x, load, self.exponent) * self.exponent

    def pressure_rise(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P), of which differences between loads are taken [stress].

        At the tip of a wedge less K ln(2 length/|x|)/pi, which all P > 0 have there and which is infinite: K ln(a/length)/pi, and
        -inf for P = 0.
        """
        distance, p = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(load, dtype=float))
        result = self.pressure(distance, p)
        tip = distance == 0
        if self.exponent == 1 and np.any(tip):
            with np.errstate(divide="ignore"):
                result[tip] = self.factor / self.length * np.log(p[tip] / self.factor) / math.pi
        return result

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load]."""
        return self._pressure(x, load, 2 * self.exponent) * self.exponent * np.asarray(load, dtype=float)

    def _pressure(self, x: ArrayLike, load: ArrayLike, exponent: float) -> Array:
        distance, p = np.broadcast_arrays(np.abs(np.asarray(x, dtype=float)), np.asarray(load, dtype=float))
        half = self.half_width(p)
        inside = (distance < half) & (p > 0)
        ratio = np.where(inside, distance / np.where(inside, half, 1.0), 1.0)
        return np.where(inside, p / np.where(inside, half, 1.0), 0.0) * pressure_function(exponent, ratio) / math.pi

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]."""
        edge, inner, zeta, rest = self._outside(x, load)
        return inner * self.reach(x, edge - inner, inner) + edge * spread_function(self.exponent, zeta, rest)

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x)."""
        edge, inner, zeta, rest = self._outside(x, load)
        return (inner**2 * self.reach(x, edge - inner, inner) + edge**2 * spread_function(2 * self.exponent, zeta, rest)) / 2

    def _outside(self, x: ArrayLike, load: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """P_x, min(P, P_x), zeta and 1 - zeta^2."""
        edge, p = np.broadcast_arrays(self.load(x), np.asarray(load, dtype=float))
        inner = np.minimum(p, edge)
        safe = np.where(edge > 0, edge, np.inf)
        zeta = np.power(inner / safe, 1 / self.exponent)
        near = np.minimum((edge - inner) / safe, _INSIDE)
        return edge, inner, zeta, np.where(near < _INSIDE, -np.expm1(2 / self.exponent * np.log1p(-near)), (1 - zeta) * (1 + zeta))

    def reach(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) from eta and P_x - eta >= 0; 0 is returned for eta = 0, where it is multiplied by eta."""
        del x
        p = np.asarray(load, dtype=float)
        # ln(|x|/a)
        ratio = np.log1p(np.asarray(excess, dtype=float) / np.where(p > 0, p, np.inf)) / self.exponent
        return ratio + np.log1p(np.sqrt(-np.expm1(-2 * ratio)))

    def root_quotient(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """sqrt((eta - P_x)/(a(eta)^2 - x^2)) from eta and eta - P_x > 0."""
        distance, rise, p = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (np.abs(x), excess, load)))
        half = np.where(p > 0, self.half_width(p), np.inf)
        part = np.minimum(rise / np.where(p > 0, p, np.inf), 1.0)
        # 1 - (x/a)^2 by the excess, which is known near the edge; far inside it has forgotten x, and x itself is known.
        ratio = distance / half
        share = np.where(
            part < _INSIDE, -np.expm1(2 / self.exponent * np.log1p(-np.minimum(part, _INSIDE))), (1 - ratio) * (1 + ratio)
        )
        fraction = np.where(part > 0, part / np.where(share > 0, share, 1.0), self.exponent / 2)
        return np.sqrt(fraction * p) / half

    def log_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P)); that of the smallest number for P = 0, where it is multiplied by P."""
        p = np.maximum(np.asarray(load, dtype=float) / self.factor, np.finfo(float).tiny)
        return math.log(2 * self.datum_length / self.length) - np.log(p) / self.exponent

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta = P [ln(2 L/a) + 1/n] [force per thickness]."""
        return np.asarray(load, dtype=float) * (self.log_ratio(load) + 1 / self.exponent)

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta = (P^2/2) [ln(2 L/a) + 1/(2 n)]."""
        return np.square(np.asarray(load, dtype=float)) / 2 * (self.log_ratio(load) + 1 / (2 * self.exponent))

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) from P and P - P_c: [P ln(P/P_c) - P + P_c]/n."""
        p = np.asarray(load, dtype=float)
        return p / self.exponent * log_excess(np.asarray(slipped, dtype=float) / np.where(p > 0, p, 1.0))
