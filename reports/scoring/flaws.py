"""Two bodies on a grid of constant tractions with flaws of a model: soft penalties, bodies that end too near.

What a flaw does is the difference between this model with it and without, on one grid, so that the grid itself drops out to first
order: it tells patterns apart, and its sizes are no figures.

# notation: h element lengths; t a traction, p pressure, q shear (n,); g initial gap; U shift; s slip, upper over lower; f friction
#           K_ij = 2/(pi E*) int ln|x_i - t| dt over element j: faces move by -K p into the bodies, s = U + K q where alike

    gap:   (K_n - C_n) p + constant - g <= 0,  p >= 0,  one of the two 0
    slip:  s = (K_t - C_t) (q - q before) + constant,  |q| <= f p,  s = 0 where |q| < f p,  q s >= 0
    C = I/k, a layer: a penalty lets faces sink by p/k and creep by q/k
    K + b (x_i - x_j)^2 h_j, a body that ends: the far field of a resultant, to its lowest order that is no rigid motion

Both are one problem: a traction between two bounds of given resultant, whose face does not move but where it is at a bound.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

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
        self._pressed: dict[tuple[float, ...], Array] = {}  # p has no memory, and no part in the shear's flaws

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
        normal, tangential = (
            self.influence + bend * self.squares - layer * np.eye(len(self.x))
            for bend, layer in ((normal_bend, normal_layer), (shear_bend, shear_layer))
        )
        gap, nothing = steepness * self.gap, np.zeros(len(self.x))
        pressures, shears, touching = [nothing], [nothing], nothing
        for load, pull in self.loads.tolist():
            key = (normal_bend, normal_layer, steepness, load)
            if load <= 0:
                self._pressed[key] = nothing
            elif key not in self._pressed:  # from the elements that touched last, if any did
                self._pressed[key] = self._settled(normal, -gap, nothing, np.full(len(gap), np.inf), load, touching)
            pressures.append(self._pressed[key])
            touching = -1.0 * (pressures[-1] <= 0) * (load > 0)
            limit = self.friction * pressures[-1]
            shears.append(self._settled(tangential, -tangential @ shears[-1], -limit, limit, pull, nothing))
        return np.array(pressures[1:]), np.array(shears[1:])

    def _settled(self, influence: Array, offset: Array, low: Array, high: Array, total: float, side: Array) -> Array:
        """t of resultant `total`, low <= t <= high; K t + constant + offset is 0 between the bounds, <= 0 at `low`, >= 0 at `high`.

        `side` (n,) is where it is looked for first: -1 at `low`, 1 at `high`, 0 between them.
        """
        scale = np.abs(influence).max()
        if not high.any():
            return high
        for _ in range(_MOST):
            free = (side == 0) & (high > low)
            traction = np.where(side < 0, low, np.where(side > 0, high, 0.0))
            if not free.any():
                raise NotSettledError("the whole contact slides")
            matrix = np.full((free.sum() + 1, free.sum() + 1), scale)  # the constant is counted in units of K
            matrix[:-1, :-1], matrix[-1, :-1], matrix[-1, -1] = influence[np.ix_(free, free)], self.shares[free], 0.0
            known = np.append(-(influence[free] @ traction + offset[free]), total - self.shares @ traction)
            solution = np.linalg.solve(matrix, known)
            traction[free] = solution[:-1]
            moves = influence @ traction + scale * solution[-1] + offset
            close, still = _TINY * np.abs(traction).max(), _TINY * np.abs(moves).max()
            below, above = free & (traction < low - close), free & (traction > high + close)
            back = (side * moves < -still) & (high > low)
            if not (below | above | back).any():
                return np.clip(traction, low, high)
            side = np.where(below, -1.0, np.where(above, 1.0, np.where(back, 0.0, side)))
        raise NotSettledError("the edges of contact or stick")
