"""Normal contact of compound curvature, 1/R1 up to x = b and 1/R2 beyond: a rounded tip plus a flat with rounded edges.

# notation: tau = sqrt(a^2 - b^2)/b, 0 up to a = b; P or eta normal load

P = (E*/R1) tip_load + (E* b^2/(2 R2)) F(tau), both terms growing: all digits are kept from R2/R1 = 0 to infinity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.chebyshev import Pieces, halved
from semi_analytic.flat_law import load_function, log_function
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.pile import Pile, rising_root
from semi_analytic.tip import tip_load, tip_log, tip_rise, tip_stiffness

Array = NDArray[np.float64]

_ROOTS = 2.0 ** np.arange(-2, 12)


@dataclass(frozen=True)
class CompoundContact(Pile):
    """Two half-planes pressed together by a profile of two curvatures. Methods as in `Contact`; R2 may be infinite (a wedge).

    >>> contact = CompoundContact(modulus=100.0, datum_length=1.0, inner_radius=1.0, outer_radius=1.0, inner_half_length=0.3)
    >>> round(float(contact.half_width(25 * np.pi)), 12)  # Hertz
    1.0
    """

    inner_radius: float
    outer_radius: float
    inner_half_length: float

    @property
    def breaks(self) -> tuple[float, ...]:
        """dP/da has a corner at a = b."""
        return (self.inner_half_length,)

    @property
    def tip(self) -> float:
        """E*/R1 [stress per length]."""
        return self.modulus / self.inner_radius

    @property
    def edge(self) -> FlatRoundedContact | None:
        """What lies outside; None for straight flanks."""
        if math.isinf(self.outer_radius):
            return None
        return FlatRoundedContact(self.modulus, self.outer_radius, self.inner_half_length, self.datum_length)

    @property
    def _units(self) -> tuple[float, float]:
        """E* b^2/(2 R) of the tip and of the edge."""
        half = self.modulus * self.inner_half_length**2 / 2
        return half / self.inner_radius, half / self.outer_radius

    def _excess(self, square: Array) -> Array:
        """P - P(b) as a function of tau^2."""
        inner, outer = self._units
        edge = load_function(np.sqrt(square))
        return inner * tip_rise(square, edge) + outer * edge

    def _slope(self, square: Array) -> Array:
        """dP/d(tau^2)."""
        inner, outer = self._units
        angle = np.arctan(np.sqrt(square))
        return inner * (np.pi / 2 - angle) + outer * angle

    @cached_property
    def _first_guess(self) -> Pieces:
        """Tau^2 over the rough value, by series of the root of the load's share."""
        inner, outer = self._units

        def quotient(root: Array) -> Array:
            share = root**2
            return rising_root(self._excess, self._slope, (inner + outer) * share, self._rough(share)) / self._rough(share)

        return halved(quotient, np.concatenate([[0.0], _ROOTS]), 1e6)

    def _rough(self, share: Array) -> Array:
        """Tau^2 for small and for large loads."""
        return share if math.isfinite(self.outer_radius) else share + np.square(share / 2)

    def tau(self, load: ArrayLike) -> Array:
        """sqrt(a^2 - b^2)/b from the load, 0 up to a = b."""
        inner, outer = self._units
        rest = np.maximum(np.asarray(load, dtype=float) - inner * np.pi / 2, 0.0)
        share = rest / (inner + outer)
        root = np.sqrt(share)
        guess = self._rough(share) * np.where(root < _ROOTS[-1], self._first_guess(np.minimum(root, _ROOTS[-1])), 1.0)
        return np.sqrt(rising_root(self._excess, self._slope, rest, guess))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]."""
        p, b = np.asarray(load, dtype=float), self.inner_half_length
        hertz = np.sqrt(4 * p / (np.pi * self.tip))
        return np.where(p <= self.tip * np.pi * b * b / 4, np.minimum(hertz, b), b * np.sqrt(1 + np.square(self.tau(p))))

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]."""
        half = np.abs(np.asarray(half_width, dtype=float))
        total = self.tip * tip_load(half, self.inner_half_length)
        return total if self.edge is None else total + self.edge.load(half)

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da [stress] = E* a [arcsin(b/a)/R1 + arccos(b/a)/R2]."""
        half, b = np.asarray(half_width, dtype=float), self.inner_half_length
        tau = np.sqrt(np.maximum((half - b) * (half + b), 0.0))
        return self.tip * tip_stiffness(half, b) + self.modulus / self.outer_radius * half * np.arctan2(tau, b)

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta = P ln(2 L/a) + int_0^a P/alpha d alpha [force per thickness]."""
        p = np.asarray(load, dtype=float)
        total = p * self.log_ratio(p) + self.tip * tip_log(self.half_width(p), self.inner_half_length)
        return total if self.edge is None else total + self.edge.unit * log_function(self.tau(p))
