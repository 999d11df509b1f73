"""Normal contact of an even polynomial h = sum c_k (x/length)^(2 k): a sum of power laws with n = 2 k, all of it elementary.

# notation: K_k load of the k-th power at a = length, t = a/length, xi = |x|/a, W = sqrt(1 - xi^2), P_x load at which a = |x|
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from scenes import InputError
from scenes.profiles import first_fall
from semi_analytic.pile import Pile, rising_root
from semi_analytic.power_law import load_factor, spread_function

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PolynomialContact(Pile):
    """Two half-planes pressed together by an even polynomial. Methods as in `Contact`.

    >>> contact = PolynomialContact(modulus=100.0, datum_length=1.0, length=1.0, rises=(0.5,))  # Hertz with R = 1
    >>> round(float(contact.half_width(25 * np.pi)), 12)
    1.0
    """

    length: float
    rises: tuple[float, ...]

    def __post_init__(self) -> None:
        # dP/da over a as a polynomial in a^2: negative somewhere, the contact would split there before it grows.
        slope = self.loads * np.arange(1, len(self.loads) + 1)
        square = first_fall(slope)
        if square is not None:
            where = self.length * float(np.sqrt(square))
            raise InputError(
                f"profile: the contact would split near a half-width of {where:.6g}; half-plane theory here needs one contact"
            )

    @cached_property
    def loads(self) -> Array:
        """K_k of k = 1, 2, ... (n,) [force per thickness]."""
        k = np.arange(1.0, len(self.rises) + 1)
        return self.modulus * 2 * k * np.array(self.rises) * np.array([load_factor(2 * each) for each in k])

    @property
    def bends_anywhere(self) -> bool:
        """Where one power ends to matter and another begins; a single one is a power law."""
        return sum(rise != 0 for rise in self.rises) > 1

    @cached_property
    def squares(self) -> Array:
        """Coefficients of P^2/2 as a polynomial in t^2, from t^2 on."""
        return np.concatenate([[0.0], polynomial.polymul(self.loads, self.loads) / 2])

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]."""
        square = np.square(np.asarray(half_width, dtype=float) / self.length)
        return np.asarray(square * polynomial.polyval(square, self.loads))

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da [stress]."""
        t = np.asarray(half_width, dtype=float) / self.length
        k = np.arange(1, len(self.loads) + 1)
        return np.asarray(2 * t / self.length * polynomial.polyval(t * t, self.loads * k))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length], by Newton's method from the nearest single power."""
        p = np.asarray(load, dtype=float)
        k = np.flatnonzero(self.loads > 0)
        single = [np.power(p / self.loads[j], 1 / (2 * j + 2)) for j in k]
        guess = self.length * np.minimum.reduce(single)
        return rising_root(self.load, self.stiffness, p, np.maximum(guess, np.finfo(float).tiny))

    def _pressure_sum(self, x: ArrayLike, load: ArrayLike, loads: Array) -> Array:
        """(1/pi) sum of 2 k K_k a^(2 k - 1)/length^(2 k) J_2k(xi); (2 k - 1) J_2k = W + (2 k - 2) xi^2 J_(2 k - 2)."""
        distance, half = np.broadcast_arrays(np.abs(np.asarray(x, dtype=float)), self.half_width(load))
        safe = np.where(half > 0, half, 1.0)
        square = np.square(np.minimum(distance / safe, 1.0))
        root = np.where(half > 0, np.sqrt(np.maximum((half - distance) * (half + distance), 0.0)), 0.0) / safe
        total, each, power = np.zeros(half.shape), np.zeros(half.shape), 1 / safe
        for k, factor in enumerate(loads, 1):
            each = (root + (2 * k - 2) * square * each) / (2 * k - 1)
            power = power * np.square(half / self.length)
            total = total + 2 * k * factor * power * each
        return total / np.pi

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        return self._pressure_sum(x, load, self.loads)

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load]."""
        return self._pressure_sum(x, load, self.squares)

    def _spread_sum(self, x: ArrayLike, load: ArrayLike, loads: Array) -> Array:
        """Sum of K_k [(a/length)^(2 k) arccosh(|x|/a) + (|x|/length)^(2 k) I_2k(a/|x|)]."""
        distance, half = np.broadcast_arrays(np.abs(np.asarray(x, dtype=float)), self.half_width(load))
        half = np.minimum(half, distance)
        safe = np.where(distance > 0, distance, 1.0)
        zeta, rest = half / safe, (distance - half) * (distance + half) / (safe * safe)
        reach = np.arcsinh(np.sqrt((distance - half) * (distance + half)) / np.where(half > 0, half, np.inf))
        total = np.zeros(half.shape)
        for k, factor in enumerate(loads, 1):
            inner, outer = ((v / self.length) ** (2 * k) for v in (half, distance))
            total = total + factor * (inner * reach + outer * spread_function(2.0 * k, zeta, rest))
        return total

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]."""
        return self._spread_sum(x, load, self.loads)

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x)."""
        return self._spread_sum(x, load, self.squares)

    def _log_sum(self, load: ArrayLike, loads: Array) -> Array:
        """Sum of K_k (a/length)^(2 k)/(2 k)."""
        square = np.square(self.half_width(load) / self.length)
        k = np.arange(1, len(loads) + 1)
        return np.asarray(square * polynomial.polyval(square, loads / (2 * k)))

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta [force per thickness]."""
        return np.asarray(load, dtype=float) * self.log_ratio(load) + self._log_sum(load, self.loads)

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta."""
        return np.square(np.asarray(load, dtype=float)) / 2 * self.log_ratio(load) + self._log_sum(load, self.squares)
