"""Two bodies on a grid of constant tractions with flaws of a model: soft penalties, bodies that end too near.

What a flaw does is the difference between this model with it and without, on one grid, so that the grid itself drops out to first
order: it tells patterns apart, and its sizes are no figures.

# notation: h element lengths; p, q tractions (n,); g initial gap; delta approach; U shift; s slip, upper over lower; f friction
#           K_ij = 2/(pi E*) int ln|x_i - t| dt over element j: faces move by -K p into the bodies, s = U + K q where alike

    gap:   g - delta - (K_n - C_n) p >= 0,  p >= 0
    slip:  s = U + (K_t - C_t) q,  |q| <= f p,  q s' >= 0
    C = I/k, a layer: a penalty lets faces sink by p/k and creep by q/k
    K + b (x_i - x_j)^2 h_j, a body that ends: the far field of a resultant, to its lowest order that is no rigid motion
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Loads that differ by less than this share of the largest P are one: those of one revolution and the next differ by rounding.
SAME_LOAD = 1e-9
_MOST, _TINY = 60, 1e-10


class NotSettledError(ArithmeticError):
    """The active sets of an increment do not converge, or the whole contact slides."""


class Model:
    """Bodies that are alike, so that p and q are even and half of the contact is enough, and the loads that they step through.

    Parameters
    ----------
    ends : (n + 1,) of the elements, from 0 up [length]
    modulus, friction, height : E* [stress], f, and the gap over x [length]
    loads : (k, 2), P and Q at the end of every increment, from the unloaded state
    """

    def __init__(self, ends: Array, modulus: float, friction: float, height: Callable[[Array], Array], loads: Array) -> None:
        self.x, lengths = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
        self.friction, self.gap = friction, np.asarray(height(self.x))
        self.influence, self.squares = np.zeros((2, len(self.x), len(self.x)))
        for image in (self.x, -self.x):
            apart = self.x[:, None] - image
            for sign, s in ((1, apart + lengths / 2), (-1, apart - lengths / 2)):
                self.influence += 2 / (np.pi * modulus) * sign * (s * np.log(np.abs(s)) - s)
            self.squares += np.square(apart) * lengths
        self.shares = 2 * lengths  # of a traction in its resultant
        unit = SAME_LOAD * float(np.abs(loads).max())
        self.loads = unit * np.round(loads / unit)
        self._pressed: dict[tuple[float, ...], Array] = {}

    def march(
        self,
        *,
        normal_layer: float = 0.0,
        shear_layer: float = 0.0,
        normal_bend: float = 0.0,
        shear_bend: float = 0.0,
        steepness: float = 1.0,
    ) -> tuple[Array, Array]:
        """p and q at the end of every increment, (k, n) each, with layers 1/k [length/stress] and bends b [1/(stress length)].

        `steepness` is a factor of the gap, and so of E* in the tractions. Each increment is one implicit step, as finite-element
        codes take it: the law holds at its end. NotSettledError where an increment has no solution or its sets do not converge.
        """
        key = (normal_bend, normal_layer, steepness)
        if key not in self._pressed:  # p has no memory, and no part in the shear's flaws
            self._pressed[key] = self._pressures(self._softened(normal_bend, normal_layer), steepness * self.gap)
        influence, shears = self._softened(shear_bend, shear_layer), [np.zeros(len(self.x))]
        for pressure, load in zip(self._pressed[key], self.loads[:, 1], strict=True):
            shears.append(self._shear(influence, shears[-1], self.friction * pressure, load))
        return self._pressed[key], np.array(shears[1:])

    def _softened(self, bend: float, layer: float) -> Array:
        return self.influence + bend * self.squares - layer * np.eye(len(self.x))

    def _bordered(self, influence: Array, free: Flags, known: Array, total: float) -> Array:
        """t on the free elements with K t + constant = -known there and shares t = total; the constant last."""
        matrix = np.zeros((len(known) + 1, len(known) + 1))
        matrix[:-1, :-1] = influence[np.ix_(free, free)]
        matrix[:-1, -1] = scale = np.abs(influence).max()
        matrix[-1, :-1] = self.shares[free]
        solution = np.linalg.solve(matrix, np.append(-known, total))
        solution[-1] *= scale
        return solution

    def _pressures(self, influence: Array, gap: Array) -> Array:
        """(k, n) at every load: no tension, no penetration; each starts from the elements that touched last, if any did."""
        found: dict[float, Array] = {}
        touching = np.ones(len(gap), dtype=bool)
        for load in self.loads[:, 0].tolist():
            if load not in found:
                found[load] = self._pressure(influence, gap, load, touching)
            touching = found[load] > 0 if load > 0 else np.ones(len(gap), dtype=bool)
        return np.array([found[load] for load in self.loads[:, 0].tolist()])

    def _pressure(self, influence: Array, gap: Array, load: float, touching: Flags) -> Array:
        for _ in range(_MOST):
            pressure = np.zeros(len(gap))
            if load <= 0:
                return pressure
            solution = self._bordered(influence, touching, -gap[touching], load)
            pressure[touching] = solution[:-1]
            opening = gap - influence @ pressure - solution[-1]
            new = np.where(touching, pressure > -_TINY * np.abs(pressure).max(), opening < -_TINY * np.ptp(gap))
            if np.array_equal(new, touching):
                return np.maximum(pressure, 0.0)
            touching = new
        raise NotSettledError("normal contact")

    def _shear(self, influence: Array, before: Array, limit: Array, load: float) -> Array:
        """q at the end of an increment: sticking elements do not move, slipping ones are at the limit, against the slip."""
        touching, slipping = limit > 0, np.zeros(len(limit))
        for _ in range(_MOST):
            stick = touching & (slipping == 0)
            traction = slipping * limit
            if not stick.any():
                if touching.any():
                    raise NotSettledError("the whole contact slides")
                return traction
            off = influence[stick] @ (traction - before)
            solution = self._bordered(influence, stick, off, load - float(self.shares @ traction))
            traction[stick] = solution[:-1]
            slip = influence @ (traction - before) + solution[-1]
            over = stick & (np.abs(traction) > limit * (1 + _TINY))
            back = (slipping != 0) & (slip * slipping < -_TINY * np.abs(slip).max())
            if not (over | back).any():
                return traction
            slipping = np.where(over, np.sign(traction), np.where(back, 0.0, slipping))
        raise NotSettledError("friction")
