"""A dense grid solver of frictional contact under P, Q, bulk strain and tilt: the oracle of the tests. Like bodies (beta = 0).

# notation: A = 2/E*; p, q tractions, constant over equal cells; C_ij = -(A/pi) int_cell ln|x_i - xi| d xi, symmetric; g gap,
#           s slip of the upper face over the lower, delta normal approach, U displacement of the upper body, alpha tilt,
#           eps = sigma_lower/E'_lower - sigma_upper/E'_upper with E' = E/(1 - nu^2)

    g = h + alpha x - delta + C p >= 0,   p >= 0,       p g = 0
    s = U - eps x - C q,                  |q| <= f p,   slip only at |q| = f p and along q

Each instant is one implicit increment from the one before. Active sets find the open, sticking and slipping cells: nothing of
superposition, memory curves or edges is used. Errors are of first order in the cell and, of the work, of second in the increment.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Turns of an active set that are allowed: it takes about ten.
_TURNS = 200
# Share of the largest f p that rounding may leave of q beyond the limit: cells that stop to slip are there.
_ROUNDING = 1e-12


class Fields(NamedTuple):
    """The answer at n instants and k cells.

    Attributes
    ----------
    x, step : (k,) middles of the cells; their width
    pressure, shear, slip : (n, k)
    state : (n, k) 0 open, 1 stick, 2 forward slip, 3 reverse slip
    approach, displacement, tilt : (n,) delta, U (of x = 0, with the datum length 1 in the logarithm), alpha
    moment, shear_moment : (n,) int x p and m_q = int x q
    work, loop : (n,) friction work of the increment that ends there and its Q dU - m_q d eps, both by the trapezoidal rule
    """

    x: Array
    step: float
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int64]
    approach: Array
    displacement: Array
    tilt: Array
    moment: Array
    shear_moment: Array
    work: Array
    loop: Array

    def edges(self, instant: int, *, stick: bool = False) -> tuple[float, float]:
        """Outer edges of the cells in contact, or of those that stick, at an instant; NaN where there are none."""
        return self._ends(self.state[instant] == 1 if stick else self.state[instant] > 0)

    def permanent_stick(self, first: int, share: float = 1e-9) -> tuple[float, float]:
        """Outer edges of the cells that stay in contact from instant `first` on and slip at most `share` of the farthest."""
        slid, stays = np.ptp(self.slip[first:], axis=0), np.all(self.state[first:] > 0, axis=0)
        return self._ends(stays & (slid <= share * np.max(slid)))

    def cycle_work(self, increments: int, *, loop: bool = False) -> Array:
        """Friction work, or closed integral of Q dU - m_q d eps, of the last whole cycles of so many increments."""
        values = (self.loop if loop else self.work)[1:]
        return values[len(values) % increments :].reshape(-1, increments).sum(axis=1)

    def _ends(self, cells: NDArray[np.bool_]) -> tuple[float, float]:
        here = self.x[cells]
        return (float(here[0] - self.step / 2), float(here[-1] + self.step / 2)) if len(here) else (math.nan, math.nan)


def solve(
    height: Callable[[Array], Array],
    extent: tuple[float, float],
    cells: int,
    friction: float,
    normal: ArrayLike,
    shear: ArrayLike,
    strain: ArrayLike = 0.0,
    tilt: ArrayLike = 0.0,
    *,
    modulus: float = 1.0,
) -> Fields:
    """Follow instants (n,) of P, Q, eps and the tilt from bodies that have never touched.

    The first instant is one increment from nothing; where P = 0 there, its eps is in place at first touch. `extent` is the grid.
    Raises ArithmeticError where active sets do not converge or the contact meets the end of the grid.

    >>> found = solve(lambda x: x**2 / 2, (-1.0, 1.0), 200, 1.0, [0.4], [0.0])  # Hertz: a = sqrt(4 P/pi), R = 1
    >>> abs(found.edges(0)[1] - (1.6 / math.pi) ** 0.5) < found.step
    True
    """
    loads = np.stack(np.broadcast_arrays(np.atleast_1d(normal), shear, strain, tilt), axis=1)
    step = (extent[1] - extent[0]) / cells
    x = extent[0] + step * (np.arange(cells) + 0.5)
    ends = step * (np.arange(cells) + np.array([[-0.5], [0.5]]))
    row = -2 / (math.pi * modulus) * np.diff(ends * (np.log(np.abs(ends)) - 1), axis=0)[0]
    compliance = row[np.abs(np.arange(cells)[:, None] - np.arange(cells))]
    heights = height(x)

    def balanced(here: NDArray[np.bool_], right: Array, total: float) -> tuple[Array, float]:
        """Tractions t of the cells `here`, C t = right + b, and b: the integral of t is the total."""
        first, second = np.linalg.solve(compliance[np.ix_(here, here)], np.stack([right[here], np.ones(here.sum())], axis=1)).T
        constant = (total / step - first.sum()) / second.sum()
        result = np.zeros(cells)
        result[here] = first + constant * second
        return result, float(constant)

    nowhere, none = np.zeros(cells, dtype=bool), np.zeros(cells)
    touching, q, s, rows, approach, shift = nowhere, none, none, [], 0.0, 0.0
    for instant, (load, force, eps, angle) in enumerate(loads.tolist()):
        before, slipped, p, direction = q, s, none, np.zeros(cells, dtype=int)
        if load <= 0:
            touching, q, s = nowhere, none, shift - eps * x
        else:
            if not touching.any():
                touching = heights + angle * x <= np.sort(heights + angle * x)[5]
            for _ in range(_TURNS):  # normal contact: p > 0 where g = 0
                p, approach = balanced(touching, -heights - angle * x, load)
                wanted = np.where(touching, p > 0, heights + angle * x - approach + compliance @ p < 0)
                if np.array_equal(wanted, touching):
                    break
                touching = wanted
            else:
                raise ArithmeticError(f"instant {instant}: the contact area does not converge")
            if touching[0] or touching[-1]:
                raise ArithmeticError(f"instant {instant}: the contact meets the end of the grid")
            limit = friction * p
            for _ in range(_TURNS):  # tangential contact: no slip where |q| < f p
                sticks, fixed = touching & (direction == 0), direction * limit
                if not sticks.any():
                    raise ArithmeticError(f"instant {instant}: all cells slip")
                right = -slipped - eps * x - compliance @ fixed
                q, shift = balanced(sticks, right, force - step * float(np.sum(fixed)))
                q = q + fixed
                s = shift - eps * x - compliance @ q
                exceeds, goes_on = sticks & (np.abs(q) > limit + _ROUNDING * limit.max()), direction * (s - slipped) > 0
                wanted = np.where(exceeds, np.sign(q), np.where(goes_on, direction, 0)).astype(int)
                if np.array_equal(wanted, direction):
                    break
                direction = wanted
            else:
                raise ArithmeticError(f"instant {instant}: the slip zones do not converge")
        state = np.where(touching, np.array([1, 2, 3])[direction], 0)
        work = step * float((before + q) @ (s - slipped)) / 2
        rows.append((p, q, s, state, approach, shift, angle, step * float(x @ p), step * float(x @ q), work))
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    middles = [(values[1:] + values[:-1]) / 2 for values in (loads[:, 1], columns[8])]
    loop = np.append(0.0, middles[0] * np.diff(columns[5]) - middles[1] * np.diff(loads[:, 2]))
    return Fields(x, step, *columns, loop)
