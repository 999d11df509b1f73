"""Unlike half-planes, coupled: what a student's grid makes of normal and shear tractions that feel each other through beta.

    python benchmarks/unlike_half_planes.py            (a minute and a half)

Shares nothing with either engine: constant tractions on a uniform grid, active sets, small increments, and turns between the
normal and the tangential problem until neither moves. Where both bodies are half-planes

    gap = g0 - delta - K p + C q >= 0,    slip = U + K q + C p,    C_ij = (beta/E*) length sgn(x_i - x_j)

(K as in discretised_half_plane.py; C both times the same, by reciprocity; beta after Johnson, Contact Mechanics, 1985, section 5.1)
The sign of beta is that of the mirror image: loads to and fro between +-Q do not see it.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from discretised_half_plane import Grid, NotSolvedError, grid, hertz_gap, press
from numpy.typing import NDArray

from scenes import Scene, load_scene

Array = NDArray[np.float64]

SCENES = {"unlike-beta-tenth": 0.1, "unlike-beta-fifth": 0.2}
_MOST, _TINY = 300, 1e-10


@dataclass(frozen=True)
class State:
    """Tractions (n,), and the sum of the friction work so far (n,) [energy / area]."""

    pressure: Array
    shear: Array
    work: Array


def coupling(on: Grid, beta: float, modulus: float) -> Array:
    """C (n, n) [length / stress]."""
    return beta / modulus * on.length * np.sign(on.x[:, None] - on.x[None, :])


def step(on: Grid, coupled: Array, gap: Array, old: State, loads: tuple[float, float], friction: float) -> State:
    """The state after an increment: normal and tangential problem by turns."""
    shear = old.shear
    touching = old.pressure > 0 if np.any(old.pressure) else np.ones(len(gap), dtype=bool)
    for _ in range(_MOST):
        pressure = press(on, gap + coupled @ shear, loads[0], touching)
        new, slip = _tangential(on, old, pressure, coupled @ (pressure - old.pressure), loads[1], friction)
        moved, shear, touching = float(np.max(np.abs(new - shear))), new, pressure > 0
        if moved <= 1e-9 * friction * float(np.max(pressure)):
            return State(pressure, shear, old.work + (old.shear + shear) / 2 * slip)
    raise NotSolvedError("normal and tangential problem by turns")


def _tangential(on: Grid, old: State, pressure: Array, by_pressure: Array, load: float, friction: float) -> tuple[Array, Array]:
    """Shear and slip of an increment in which the pressure alone would slip the faces by `by_pressure`, (n,) each."""
    limit, touching = friction * pressure, pressure > 0
    slipping = np.where(touching & (old.pressure == 0), 0.0, np.sign(old.shear) * (np.abs(old.shear) >= limit * (1 - 1e-12)))
    for _ in range(_MOST):
        stick = touching & (slipping == 0)
        traction = np.where(touching, slipping * limit, 0.0)
        if not np.any(stick):
            raise NotSolvedError("gross sliding of the grid")
        known = on.influence @ (traction - old.shear) + by_pressure
        count = int(np.sum(stick))
        matrix = np.zeros((count + 1, count + 1))
        matrix[:-1, :-1], matrix[:-1, -1], matrix[-1, :-1] = on.influence[np.ix_(stick, stick)], 1.0, on.length
        answer = np.linalg.solve(matrix, np.append(-known[stick], load - on.length * float(np.sum(traction))))
        traction[stick] = answer[:-1]
        slip = on.influence @ (traction - old.shear) + by_pressure + answer[-1]
        over = stick & (np.abs(traction) > limit * (1 + _TINY))
        back = (slipping != 0) & (slip * slipping < -_TINY * float(np.max(np.abs(slip[touching]), initial=0.0)))
        if not np.any(over | back):
            return traction, np.where(touching & ~stick, slip, 0.0)
        slipping = np.where(over, np.sign(traction), np.where(back, 0.0, slipping))
    raise NotSolvedError("friction")


@dataclass(frozen=True)
class Figures:
    """Friction work of the last of two cycles [energy / thickness], largest pressure in it [stress]."""

    dissipation: float
    peak: float


def solve(scene: Scene, beta: float, elements: int, increments: int) -> Figures:
    """A polygon scene of Hertz' profile on a grid of 1.15 half-widths, `increments` to a leg."""
    modulus = 1 / sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (scene.material.lower, scene.material.upper))
    largest = max(p for p, _ in scene.load.initial_loading)
    half_width = np.sqrt(4 * largest * scene.profile.radius / (np.pi * modulus))
    on = grid(1.15 * half_width, elements, modulus)
    coupled, gap = coupling(on, beta, modulus), hertz_gap(scene.profile.radius)(on.x)
    state = State(*(np.zeros(elements) for _ in range(3)))
    corners = [(0.0, 0.0), *scene.load.initial_loading, *2 * (*scene.load.cycle, scene.load.initial_loading[-1])]
    per_cycle, works, peaks = len(scene.load.cycle) + 1, [], []
    for number, (first, last) in enumerate(pairwise(corners)):
        for loads in _increments(first, last, increments, from_nothing=number == 0):
            state = step(on, coupled, gap, state, loads, scene.friction.coefficient)
        works.append(on.length * float(np.sum(state.work)))
        peaks.append(float(np.max(state.pressure)))
    return Figures(works[-1] - works[-1 - per_cycle], max(peaks[-per_cycle:]))


def _increments(
    first: tuple[float, float], last: tuple[float, float], count: int, *, from_nothing: bool
) -> Sequence[tuple[float, float]]:
    """Loads at the ends; from nothing on in equal steps of the half-width, which goes with the root of P."""
    parts = [(k / count) ** (2 if from_nothing else 1) for k in range(1, count + 1)]
    return [(first[0] + part * (last[0] - first[0]), first[1] + part * (last[1] - first[1])) for part in parts]


def main() -> int:
    """Print both scenes on three grids, without coupling first."""
    print(f"{'scene':20} {'beta':>5} {'elements':>8} {'a leg':>6} {'dissipation':>16} {'peak pressure':>16}")
    for name, beta in SCENES.items():
        for coupled in (0.0, beta):
            for elements, increments in ((100, 20), (200, 40), (400, 80)):
                found = solve(load_scene(name), coupled, elements, increments)
                print(f"{name:20} {coupled:5} {elements:8} {increments:6} {found.dissipation:16.9g} {found.peak:16.9g}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
