"""Normal contact of a tabulated profile: its curvature is constant between knots, so that every kernel is a sum of rounded tips.

# notation: b_j knots, kappa_j = h'' between b_j and b_(j+1), T(b) the kernel of a rounded tip of half-length b

kernel = E* sum kappa_j [T(b_(j+1)) - T(b_j)]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError
from semi_analytic.pile import Pile, in_chunks, rising_root
from semi_analytic.tip import tip_load, tip_log, tip_pressure, tip_spread, tip_stiffness

Array = NDArray[np.float64]

_BREAKS = 24
_FEW = 16
_MANY = 300
_NEAR = 0.02
_GAUSS = np.polynomial.legendre.leggauss(24)
_SQUARE, _STEP = np.square((1 + _GAUSS[0]) / 2), (1 + _GAUSS[0]) / 2 * _GAUSS[1]


@dataclass(frozen=True, eq=False)
class TabulatedContact(Pile):
    """Two half-planes pressed together by a profile of piecewise constant curvature. Methods as in `Contact`.

    Attributes
    ----------
    knots : (n + 1,) from 0 up
    curvature : (n,) h'' between them
    """

    knots: Array
    curvature: Array

    def __post_init__(self) -> None:
        half = np.linspace(0.5, 1.0, 4) * np.diff(self.knots)[:, None] + self.knots[:-1, None]
        stiffness = self.stiffness(half)
        falls = stiffness < -1e-12 * np.max(stiffness)
        if np.any(falls):
            raise InputError(
                f"profile: the contact would split near a half-width of {half[falls][0]:.6g}; smooth the rows until it does not"
            )

    def _sum(self, kernel: Callable[..., Array], *arguments: ArrayLike) -> Array:
        """E* sum over the knots of kappa_j [T(b_(j+1)) - T(b_j)]."""
        # Knots that nothing has reached are all alike to a kernel.
        reached = int(np.searchsorted(self.knots, float(np.max(arguments[-1], initial=0.0)))) + 1
        ends, bend = self.knots[1:reached], self.curvature[: reached - 1]
        values = kernel(*(np.asarray(v, dtype=float)[..., None] for v in arguments), ends)
        return self.modulus * np.sum(np.diff(values, axis=-1, prepend=0.0) * bend, axis=-1)

    @property
    def least(self) -> float:
        """Half-length of the flat, if the profile starts with one."""
        bent = np.flatnonzero(self.curvature > 0)
        return float(self.knots[bent[0]])

    @property
    def breaks(self) -> tuple[float, ...]:
        """The knots; of very many, those where the curvature changes most: quadrature steps over the others."""
        if len(self.knots) < _MANY:
            return tuple(self.knots[1:-1].tolist())
        jump = np.abs(np.diff(self.curvature))
        most = np.argsort(jump)[::-1][:_BREAKS]
        most = most[jump[most] > 1e-9 * np.max(np.abs(self.curvature))]
        return tuple(sorted(self.knots[1:-1][most].tolist()))

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]."""
        return in_chunks(lambda a, _: self._sum(tip_load, a), np.abs(half_width), 0.0, len(self.knots))

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da [stress]."""
        return in_chunks(lambda a, _: self._sum(tip_stiffness, a), np.abs(half_width), 0.0, len(self.knots))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length], by Newton's method.

        Raises
        ------
        InputError
            For a load that needs a contact wider than the table.
        """
        p = np.asarray(load, dtype=float)
        marks = self._marks
        most = float(np.max(p, initial=0.0))
        if most > marks[1][-1]:
            raise InputError(
                f"profile: the normal load {most:.6g} needs a contact wider than the table, whose last x = {self.knots[-1]:.6g} "
                f"carries {marks[1][-1]:.6g}"
            )
        least, flat = self.least, p.ravel()
        different, fold = np.unique(flat, return_inverse=True)
        guess = np.interp(different, marks[1], marks[0]) - least
        first = self._first_guess(different)
        guess = np.where(different < marks[1][1], first, guess)
        above = rising_root(lambda t: self.load(least + t), lambda t: self.stiffness(least + t), different, guess)
        return (least + above)[fold].reshape(p.shape)

    @property
    def _marks(self) -> tuple[Array, Array]:
        knots = self.knots[self.knots >= self.least]
        return knots, np.maximum.accumulate(self.load(knots))

    def _first_guess(self, load: Array) -> Array:
        """Within the first curved piece: Hertz, or P = (2/3) E* kappa sqrt(2 b) t^(3/2) beside a flat."""
        least = self.least
        bend = self.modulus * float(self.curvature[self.curvature > 0][0])
        if least == 0:
            return np.sqrt(4 * load / (np.pi * bend))
        return np.power(load / (2 / 3 * bend * np.sqrt(2 * least)), 2 / 3)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        half = self.half_width(load)
        return np.maximum(in_chunks(lambda at, a: self._sum(tip_pressure, at, a), np.abs(x), half, len(self.knots)), 0.0)

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]."""
        distance, half = np.broadcast_arrays(np.abs(np.asarray(x, dtype=float)), self.half_width(load))
        inner = np.minimum(half, distance)
        return in_chunks(lambda at, a: self._sum(tip_spread, at, a), distance, inner, len(self.knots))

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta [force per thickness]."""
        p = np.asarray(load, dtype=float)
        return p * self.log_ratio(p) + self._sum(tip_log, self.half_width(p))

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) = P p - int p d eta, by quadrature; over many knots it steps: 1e-3 for forty rows."""
        if len(self.knots) < _FEW:
            return super().pressure_moment(x, load)
        distance, half = np.broadcast_arrays(np.abs(np.asarray(x, dtype=float)), self.half_width(load))
        first = np.minimum(np.maximum(distance, self.least), half)
        # p starts like the root of the distance from x.
        width = (half - first)[..., None]
        inside = self._integral(tip_pressure, distance, first[..., None] + width * _SQUARE, width * _STEP)
        return np.asarray(load, dtype=float) * self.pressure(distance, load) - inside

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta, likewise from S."""
        if len(self.knots) < _FEW:
            return super().spread_moment(x, load)
        distance, half = np.broadcast_arrays(np.abs(np.asarray(x, dtype=float)), self.half_width(load))
        last = np.maximum(np.minimum(half, distance), self.least)
        width = (last - self.least)[..., None]
        inside = self._integral(tip_spread, distance, last[..., None] - width * _SQUARE, width * _STEP)
        whole = in_chunks(lambda at, a: self._sum(tip_spread, at, a), distance, np.minimum(last, distance), len(self.knots))
        return np.asarray(self.load(last) * whole - inside)

    def _integral(self, kernel: Callable[..., Array], x: Array, half: Array, weight: Array) -> Array:
        """int kernel dP over half-widths (..., nodes)."""
        beyond = np.minimum(half, x[..., None]) if kernel is tip_spread else half
        values = in_chunks(lambda at, a: self._sum(kernel, at, a), x[..., None], beyond, len(self.knots))
        return np.asarray(np.sum(weight * values * self.stiffness(half), axis=-1))

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) from P and P - P_c: P ln(a/c) less the difference of int P/alpha, by quadrature where the two are close."""
        p, d = np.broadcast_arrays(np.asarray(load, dtype=float), np.asarray(slipped, dtype=float))
        half, front = self.half_width(p), self.half_width(np.maximum(p - d, 0.0))
        safe = np.where(front > 0, front, np.finfo(float).tiny)
        far = p * np.log(half / safe) - (self._sum(tip_log, half) - self._sum(tip_log, front))
        near = d < _NEAR * p
        result = np.array(far)
        if np.any(near):
            result[near] = super().log_area(p[near], d[near])
        return result
