"""Unsymmetric contact: tilt and bulk strain beside P and Q, as long as the memory of friction stays one curve.

# notation: alpha tilt (gap = h + alpha x - approach), eps difference of the bulk strains, A = 2/E*; eta normal load, I(eta) contact
#           interval of load eta and tilt alpha_0 + kappa eta, m its centre, c its half-length, t = x - m; M(eta) memory curve

Where tilt and bulk strain are the same affine function of the loads, alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q, the
intervals I(eta) take the place of the flat punches of a symmetric contact. They are nested while |kappa| <= A/(pi a). The memory
curve is what it is without tilt and bulk, and its integrals take other kernels:

    dp/d eta = [1/pi - (kappa/A) t]/sqrt(c^2 - t^2)                                       inside, q = int M' dp
    s = (A/pi) int M' [arccosh(|t|/c) - (pi kappa/A) sgn(t) sqrt(t^2 - c^2)] d eta        outside
    U = (A/pi) int M' [ln(2 L/c) + (pi kappa/A) m] d eta                                  of x = 0
    m_q = int x q = int M' mu d eta,  mu = m - (pi kappa/(2 A)) c^2,  and int x p = int mu d eta
    W = closed-int Q dU - m_q d eps = -closed-int (U + kappa m_q) dQ

An increment of Q alone that is stuck on I would leave q symmetric about m; the increment kappa dQ of bulk strain leans it as the
increment kappa dP of tilt leans p. So q stays a sum of the same increments that p is a sum of. No source is known for this family;
kappa = 0 is the theorem of Ciavarella and Jaeger for unsymmetric profiles, constant P the bulk stress of Nowell and Hills 1987.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semi_analytic.hertz import HertzContact
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]

_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class TiltedParabola(HertzContact):
    """The parabola h = x^2/(2 R) under the tilt alpha_0 + kappa eta, in closed form; points x carry their sign.

    # notation: S = c^2/eta, X = x + alpha_0 R, g = kappa R: t = X + g eta, t^2 - c^2 = (P_x - eta)(T - g^2 eta), P_x = X^2/T

    Attributes
    ----------
    tilt, slope : alpha_0 and kappa [1/force per thickness]; a tilt may be an array that broadcasts with x where kappa = 0
    rigid : what `log_ratio` and its integrals are over A/pi: the rate of U, of U + kappa m_q ("loop"), or mu itself ("moment")
    """

    tilt: float | Array = 0.0
    slope: float = 0.0
    rigid: Literal["displacement", "loop", "moment"] = "displacement"

    @property
    def _lean(self) -> float:
        """g."""
        return self.slope * self.radius

    def centre(self, load: ArrayLike) -> Array:
        """m(eta) = -alpha R [length]."""
        return -(self.tilt * self.radius + self._lean * np.asarray(load, dtype=float))

    def interval(self, load: ArrayLike) -> Array:
        """Ends of I(eta) [length], a new last axis.

        >>> contact = TiltedParabola(modulus=1.0, radius=1.0, datum_length=1.0, tilt=0.1)
        >>> contact.interval(np.pi / 4).round(12).tolist()  # a = 1
        [-1.1, 0.9]
        """
        return self.centre(load)[..., None] + self.half_width(load)[..., None] * np.array([-1.0, 1.0])

    @property
    def largest(self) -> float:
        """The load up to which intervals are nested: there |kappa| = A/(pi a)."""
        return self.stretch / (2 * self._lean) ** 2 if self.slope else np.inf

    def _from_axis(self, x: ArrayLike) -> tuple[Array, Array, Array]:
        """X, T and P_x; infinite where no nested interval reaches x."""
        place, square = np.asarray(x, dtype=float) + self.tilt * self.radius, self.stretch
        root = square * (square - 4 * self._lean * place)
        other = (square - 2 * self._lean * place + np.sqrt(np.maximum(root, 0.0))) / 2
        return place, other, np.where(root >= 0, place * place / np.where(root >= 0, other, 1.0), np.inf)

    def _square(self, x: ArrayLike, excess: ArrayLike, load: Array) -> tuple[Array, Array]:
        """T and t^2 - c^2 from P_x - eta and eta, free of cancellation where P_x is finite."""
        place, other, edge = self._from_axis(x)
        close = np.asarray(excess, dtype=float) * (other - self._lean**2 * load)
        far = np.square(place + self._lean * load) - self.stretch * load
        return place, np.where(np.isfinite(edge), close, far)

    def load(self, half_width: ArrayLike) -> Array:
        """P_x: the load at which x is an end of I(eta) [force per thickness].

        >>> contact = TiltedParabola(modulus=1.0, radius=1.0, datum_length=1.0, tilt=0.1, slope=0.2)
        >>> contact.load(contact.interval(0.7)).round(12).tolist()
        [0.7, 0.7]
        """
        return self._from_axis(half_width)[2]

    def load_at(self, advance: ArrayLike) -> Array:
        """eta from c."""
        return HertzContact.load(self, advance)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        load = np.asarray(load, dtype=float)
        excess = np.maximum(load - self.load(x), 0.0)
        return np.sqrt(excess * np.maximum(self._from_axis(x)[1] - self._lean**2 * load, 0.0)) * (2 / (np.pi * self.stretch))

    pressure_rise = pressure

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load]: P p less int p d eta."""
        load = np.asarray(load, dtype=float)
        edge = np.minimum(self.load(x), load)
        eta, weight = graded(edge, np.broadcast_to(load, edge.shape))
        return load * self.pressure(x, load) - np.sum(weight * self.pressure(np.asarray(x)[..., None], eta), axis=-1)

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^eta of the kernel of slip over loads at which x is open [force per thickness].

        Over pi/A it is what the gap of x closes by: [X^2 - |t| sqrt(t^2 - c^2) + c^2 arccosh(|t|/c)]/S.

        >>> contact = TiltedParabola(modulus=1.0, radius=1.0, datum_length=1.0, tilt=0.1, slope=0.2)
        >>> round(2 / np.pi * float(contact.slip_integral(0.6, contact.load(0.6))), 12)  # (0.6 + 0.1)^2/2
        0.245
        """
        edge = self.load(x)
        inner = np.minimum(np.asarray(load, dtype=float), edge)
        place, square = self._square(x, edge - np.where(np.isfinite(edge), inner, 0.0), inner)
        root, t = np.sqrt(np.maximum(square, 0.0)), place + self._lean * inner
        angle = np.arcsinh(root / np.sqrt(np.where(inner > 0, self.stretch * inner, np.inf)))
        # X^4 - t^2 (t^2 - c^2) over eta, for the digits of the difference.
        closing = self.stretch * t * t - self._lean * (place + t) * (place * place + t * t)
        return inner * (angle + closing / (self.stretch * (place * place + np.abs(t) * root) + _TINY))

    def slip_integral_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """The same with eta in front [force^2 per thickness^2]."""
        edge = self.load(x)
        inner = np.minimum(np.asarray(load, dtype=float), edge)
        eta, weight = graded(np.zeros(inner.shape), inner)
        ratio = self.arccosh_ratio(np.asarray(x)[..., None], edge[..., None] - eta, self.half_width(eta))
        return np.sum(weight * eta * ratio, axis=-1)

    def arccosh_ratio(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """The kernel of slip from P_x - eta >= 0 and c."""
        half = np.asarray(advance, dtype=float)
        place, square = self._square(x, excess, self.load_at(half))
        root = np.sqrt(np.maximum(square, 0.0))
        return np.arcsinh(root / np.where(half > 0, half, np.inf)) - 2 * self._lean / self.stretch * np.sign(place) * root

    def inverse_root(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """pi dp/d eta from eta - P_x > 0 and c."""
        load = self.load_at(advance)
        place, square = self._square(x, -np.asarray(excess, dtype=float), load)
        weight = 1 - 2 * self._lean / self.stretch * (place + self._lean * load)
        return weight / np.sqrt(np.where(square < 0, -square, np.inf))

    def _extra(self) -> tuple[float, float | Array, float]:
        """Share of ln(2 L/c), and u and v of what `rigid` adds to it: u + v eta."""
        first, second = self.tilt * self.radius, self._lean / self.stretch
        if self.rigid == "moment":
            return 0.0, -first, -2 * self._lean
        return (
            (1.0, -2 * second * first, -2 * second * self._lean)
            if self.rigid == "displacement"
            else (1.0, -4 * second * first, -6 * second * self._lean)
        )

    def log_ratio(self, load: ArrayLike) -> Array:
        p = np.asarray(load, dtype=float)
        share, u, v = self._extra()
        return share * super().log_ratio(p) + u + v * p

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P of `log_ratio`."""
        p = np.asarray(load, dtype=float)
        share, u, v = self._extra()
        return share * p * (HertzContact.log_ratio(self, p) + 0.5) * (p > 0) + p * (u + v * p / 2)

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P of eta times `log_ratio`."""
        p = np.asarray(load, dtype=float)
        share, u, v = self._extra()
        return share * p * p / 2 * (HertzContact.log_ratio(self, p) + 0.25) * (p > 0) + p * p * (u / 2 + v * p / 3)

    def dissipation_kernel(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam = int_{P_c}^P of the loop's rate at P_c less that at eta: (3 g^2/S) (P - P_c)^2 more than without kappa."""
        return super().dissipation_kernel(load, slipped) + 3 * self._lean**2 / self.stretch * np.square(slipped)

    def is_nested(self, load: float) -> bool:
        """Whether every I(eta) up to a load holds all that come before it."""
        return load <= self.largest * (1 + 1e-11)

    def under(self, load: Array, tilt: Array) -> tuple[Array, Array]:
        """m and c of the contact of loads and tilts (n,)."""
        return -tilt * self.radius, HertzContact.half_width(self, load)

    def pressure_over(self, x: Array, m: Array, c: Array) -> Array:
        """p at points (k,) of contacts (n,): (n, k)."""
        t, c = x - m[:, None], c[:, None]
        return np.asarray(np.sqrt(np.maximum((c - t) * (c + t), 0.0)) * (2 / (np.pi * self.stretch)))

    def approach(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """Normal approach at x = 0 of contacts (n,) [length]: -alpha^2 R/2 at first touch."""
        del c
        rise = load * (HertzContact.log_ratio(self, load) + 0.5) * (load > 0) * self.stretch / (2 * self.radius)
        return np.asarray(rise + tilt * m / 2)

    def moment(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """int x p of contacts (n,) [force]."""
        del c, tilt
        return m * load
