"""The naive peer of both engines: constant tractions on a uniform grid of two half-planes, like or unlike; active sets, increments.

    python benchmarks/unlike_half_planes.py            (a minute and a half: the expected values of the scenes unlike-beta-*)

What a good student writes in an afternoon, and what many papers use. It shares nothing with either engine. Plane strain, loads per
unit thickness. Where normal and shear tractions are coupled through beta, the two problems take turns until neither moves.

# notation: h element length, K_ij = (1/(pi E*)) 2 int ln|x_i - s| ds over element j; C_ij = (beta/E*) h sgn(x_i - x_j);
#           p, q tractions (n,); gap = g0 - delta - K p + C q >= 0, slip = U + K q + C p (Johnson, Contact Mechanics, 1985,
#           section 5.1; the sign of beta is that of the mirror image: loads to and fro between +-Q do not see it)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import Scene, load_scene

Array = NDArray[np.float64]
SCENES = {"unlike-beta-tenth": 0.1, "unlike-beta-fifth": 0.2}
_MOST, _TINY = 300, 1e-11


class NotSolvedError(RuntimeError):
    """The active sets did not converge."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Elements of a half-plane pair: centres x (n,), their length, K (n, n) [length/stress], C alike, None for like bodies."""

    x: Array
    length: float
    influence: Array
    coupling: Array | None = None


def grid(half_length: float, elements: int, modulus: float, beta: float = 0.0) -> Grid:
    """`elements` elements on [-half_length, half_length]; `modulus` is E*."""
    length = 2 * half_length / elements
    x = -half_length + length * (np.arange(elements) + 0.5)
    distance = x[:, None] - x[None, :]

    def primitive(s: Array) -> Array:
        return s * np.log(np.abs(s)) - s

    influence = 2 / (np.pi * modulus) * (primitive(distance + length / 2) - primitive(distance - length / 2))
    return Grid(x, length, influence, coupling(x, length, beta, modulus) if beta else None)


def coupling(x: Array, length: float, beta: float, modulus: float) -> Array:
    """C (n, n) [length / stress]."""
    return beta / modulus * length * np.sign(x[:, None] - x[None, :])


class State(NamedTuple):
    """Tractions (n,), and the sum of the friction work so far by element (n,) [energy per area]."""

    pressure: Array
    shear: Array
    work: Array


def press(on: Grid, gap: Array, load: float, guess: NDArray[np.bool_] | None = None) -> Array:
    """Pressures under a load: no tension, no penetration, by dropping and adding elements."""
    touching = guess if guess is not None and np.any(guess) else np.ones(len(gap), dtype=bool)
    for _ in range(_MOST):
        solution = _bordered(on, touching, -gap[touching], load)
        pressure = np.zeros(len(gap))
        pressure[touching] = solution[:-1]
        opening = gap - on.influence @ pressure - solution[-1]
        new = np.where(touching, pressure > -_TINY * float(np.max(np.abs(pressure))), opening < -_TINY * float(np.ptp(gap)))
        if np.array_equal(new, touching):
            return np.maximum(pressure, 0.0)
        touching = new
    raise NotSolvedError("normal contact")


def _bordered(on: Grid, free: NDArray[np.bool_], known: Array, total: float) -> Array:
    """Tractions t on the free elements and the constant C with K t + C = -known there and length sum t = total."""
    count = int(np.sum(free))
    matrix = np.zeros((count + 1, count + 1))
    matrix[:-1, :-1], matrix[:-1, -1], matrix[-1, :-1] = on.influence[np.ix_(free, free)], 1.0, on.length
    return np.linalg.solve(matrix, np.append(-known, total))


def shear(on: Grid, old: State, pressure: Array, load: float, friction: float) -> tuple[Array, Array]:
    """Shear and slip of one increment, (n,) each: sticking elements do not move, slipping ones are at the limit."""
    limit, touching = friction * pressure, pressure > 0
    by_pressure = on.coupling @ (pressure - old.pressure) if on.coupling is not None else 0.0 * pressure
    slipping = np.zeros(len(pressure))
    for _ in range(_MOST):
        stick = touching & (slipping == 0)
        traction = np.where(touching, slipping * limit, 0.0)
        if not np.any(stick):
            raise NotSolvedError("gross sliding of the grid")
        known = on.influence[stick] @ (traction - old.shear) + by_pressure[stick]
        solution = _bordered(on, stick, known, load - on.length * float(np.sum(traction)))
        traction[stick] = solution[:-1]
        slip = on.influence @ (traction - old.shear) + by_pressure + solution[-1]
        over = stick & (np.abs(traction) > limit * (1 + _TINY))
        back = (slipping != 0) & (slip * slipping < -_TINY * float(np.max(np.abs(slip[touching]), initial=0.0)))
        if not np.any(over | back):
            return traction, np.where(touching & ~stick, slip, 0.0)
        slipping = np.where(over, np.sign(traction), np.where(back, 0.0, slipping))
    raise NotSolvedError("friction")


def step(on: Grid, gap: Array, old: State, loads: tuple[float, float], friction: float) -> State:
    """The state after an increment of the loads; friction work by the trapezoidal rule."""
    traction, touching = old.shear, old.pressure > 0
    for _ in range(_MOST):
        opened = gap if on.coupling is None else gap + on.coupling @ traction
        pressure = press(on, opened, loads[0], touching)
        new, slip = shear(on, old, pressure, loads[1], friction)
        moved, traction, touching = float(np.max(np.abs(new - traction))), new, pressure > 0
        if on.coupling is None or moved <= 1e-9 * friction * float(np.max(pressure)):
            return State(pressure, traction, old.work + (old.shear + traction) / 2 * slip)
    raise NotSolvedError("normal and tangential problem by turns")


Loads = Sequence[tuple[float, float]]


def dissipation(on: Grid, gap: Array, initial_loading: Loads, cycle: Loads, friction: float) -> tuple[float, float]:
    """Work of the last of two cycles, and the largest pressure in it; loads (P, Q) are at the ends of increments."""
    state = State(*(np.zeros(len(on.x)) for _ in range(3)))
    for leg in (initial_loading, cycle, cycle):
        before, peak = state, 0.0
        for loads in leg:
            state = step(on, gap, state, loads, friction)
            peak = max(peak, float(np.max(state.pressure)))
    return on.length * float(np.sum(state.work - before.work)), peak


def solve(scene: Scene, beta: float, elements: int, increments: int) -> tuple[float, float]:
    """The same of a polygon scene of Hertz' profile on a grid of 1.15 half-widths, `increments` to a line.

    The first line goes in equal steps of the half-width, which goes with the root of P.
    """
    modulus = 1 / sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (scene.material.lower, scene.material.upper))
    largest = max(p for p, _ in scene.load.initial_loading)
    on = grid(1.15 * np.sqrt(4 * largest * scene.profile.radius / (np.pi * modulus)), elements, modulus, beta)
    share = np.arange(1, increments + 1) / increments

    def along(corners: Loads, first: bool) -> list[tuple[float, float]]:
        found = []
        for number, (a, b) in enumerate(pairwise(corners)):
            parts = share**2 if first and number == 0 else share
            found += [(a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])) for part in parts.tolist()]
        return found

    end = scene.load.initial_loading[-1]
    cycle = along([end, *scene.load.cycle, end], first=False)
    initial_loading = along([(0.0, 0.0), *scene.load.initial_loading], first=True)
    return dissipation(on, on.x**2 / (2 * scene.profile.radius), initial_loading, cycle, scene.friction.coefficient)


def main() -> None:
    """Print both scenes on three grids, without coupling first."""
    print(f"{'scene':20} {'beta':>5} {'elements':>8} {'a line':>6} {'dissipation':>16} {'peak pressure':>16}")
    for name, largest in SCENES.items():
        for beta in (0.0, largest):
            for elements, increments in ((100, 20), (200, 40), (400, 80)):
                work, peak = solve(load_scene(name), beta, elements, increments)
                print(f"{name:20} {beta:5} {elements:8} {increments:6} {work:16.9g} {peak:16.9g}", flush=True)


if __name__ == "__main__":
    main()
