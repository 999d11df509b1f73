"""The naive peer of the half-plane engine: constant tractions on a uniform grid, influence coefficients, active sets, increments.

What a good student writes in an afternoon, and what many papers use. It shares nothing with `semi_analytic`;
`semi_analytic_precision.py` puts the two side by side. Two like bodies in plane strain, loads per unit thickness.

# notation: h element length, K_ij = (1/(pi E*)) 2 int ln|x_i - s| ds over element j; p, q tractions (n,); g0 initial gap;
#           gap = g0 - delta - K p >= 0,  slip = U + K q, constants fixed by the loads P, Q; s upper over lower, q s' >= 0
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Loads = tuple[float, float]
"""(P, Q)."""

_MOST = 200
_TINY = 1e-11


@dataclass(frozen=True, eq=False)
class Grid:
    """Elements of a half-plane pair: centres x (n,), their length, K (n, n) [length/stress]."""

    x: Array
    length: float
    influence: Array


def grid(half_length: float, elements: int, modulus: float) -> Grid:
    """`elements` elements on [-half_length, half_length]; `modulus` is E*."""
    length = 2 * half_length / elements
    x = -half_length + length * (np.arange(elements) + 0.5)
    distance = x[:, None] - x[None, :]

    def primitive(s: Array) -> Array:
        return s * np.log(np.abs(s)) - s

    return Grid(x, length, 2 / (np.pi * modulus) * (primitive(distance + length / 2) - primitive(distance - length / 2)))


class State(NamedTuple):
    """Tractions (n,), and the sum of the friction work so far by element (n,) [energy per area]."""

    pressure: Array
    shear: Array
    work: Array


class NotSolvedError(RuntimeError):
    """The active sets did not settle."""


def press(on: Grid, gap: Array, load: float, guess: Flags) -> Array:
    """Pressures under a load: no tension, no penetration, by dropping and adding elements."""
    touching = guess
    for _ in range(_MOST):
        solution = _bordered(on, touching, -gap[touching], load)
        pressure = np.zeros(len(gap))
        pressure[touching] = solution[:-1]
        opening = gap - on.influence @ pressure - solution[-1]
        size = float(np.max(np.abs(pressure)))
        new = np.where(touching, pressure > -_TINY * size, opening < -_TINY * float(np.ptp(gap)))
        if np.array_equal(new, touching):
            return np.maximum(pressure, 0.0)
        touching = new
    raise NotSolvedError("normal contact")


def _bordered(on: Grid, free: Flags, known: Array, total: float) -> Array:
    """Tractions t on the free elements and the constant C with K t + C = -known there and length sum t = total."""
    count = int(np.sum(free))
    matrix = np.zeros((count + 1, count + 1))
    matrix[:-1, :-1] = on.influence[np.ix_(free, free)]
    matrix[:-1, -1] = 1.0
    matrix[-1, :-1] = on.length
    return np.linalg.solve(matrix, np.append(-known, total))


def shear(on: Grid, old: State, pressure: Array, load: float, friction: float) -> tuple[Array, Array]:
    """Shear and slip of one increment, (n,) each: sticking elements do not move, slipping ones are at the limit."""
    limit, touching = friction * pressure, pressure > 0
    slipping = np.zeros(len(pressure))
    for _ in range(_MOST):
        stick = touching & (slipping == 0)
        traction = slipping * limit
        if not np.any(stick):
            raise NotSolvedError("gross sliding of the grid")
        # K (q - old) + dU = 0 where it sticks
        off = on.influence[stick] @ (traction - old.shear)
        solution = _bordered(on, stick, off, load - on.length * float(np.sum(traction)))
        traction[stick] = solution[:-1]
        slip = on.influence @ (traction - old.shear) + solution[-1]
        over = stick & (np.abs(traction) > limit * (1 + _TINY))
        back = (slipping != 0) & (slip * slipping < -_TINY * float(np.max(np.abs(slip), initial=0.0)))
        if not np.any(over | back):
            return traction, np.where(touching & ~stick, slip, 0.0)
        slipping = np.where(over, np.sign(traction), np.where(back, 0.0, slipping))
    raise NotSolvedError("friction")


def step(on: Grid, gap: Array, old: State, normal: float, tangential: float, friction: float) -> State:
    """The state after an increment of the loads; friction work by the trapezoidal rule."""
    guess = old.pressure > 0
    pressure = press(on, gap, normal, guess if np.any(guess) else np.ones(len(gap), dtype=bool))
    traction, slip = shear(on, old, pressure, tangential, friction)
    return State(pressure, traction, old.work + (old.shear + traction) / 2 * slip)


def dissipation(
    on: Grid,
    gap: Callable[[Array], Array],
    initial_loading: Sequence[tuple[float, float]],
    cycle: Sequence[tuple[float, float]],
    friction: float,
) -> tuple[float, Array, State]:
    """Work of the last of two cycles, the same per unit area (n,), and the last state; loads are at the ends of increments."""
    shape = gap(on.x)
    state = State(*(np.zeros(len(on.x)) for _ in range(3)))
    before = state
    for leg in (initial_loading, cycle, cycle):
        before = state
        for normal, tangential in leg:
            state = step(on, shape, state, normal, tangential, friction)
    density = state.work - before.work
    return on.length * float(np.sum(density)), density, state


def hertz_gap(radius: float) -> Callable[[Array], Array]:
    """x^2/(2R)."""
    return lambda x: x * x / (2 * radius)


def flat_rounded_gap(radius: float, flat: float) -> Callable[[Array], Array]:
    """0 up to `flat`, (|x| - flat)^2/(2R) beyond."""
    return lambda x: np.maximum(np.abs(x) - flat, 0.0) ** 2 / (2 * radius)
