"""Unlike bodies: the grid is of the order that it claims, with coupling and without, and able to fail; closed solutions by FE."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import halfplane_fe
from meshes import MeshSettings
from scenes import ContactSolution, Scene, load_scene
from semi_analytic import grid as dense_grid

P, F, K = math.pi / 4, 0.5, 0.6  # E* = R = a = 1
NAMES = {"unlike-beta-tenth": 0.1, "unlike-beta-fifth": 0.2}


def order(sizes: tuple[int, ...], errors: list[float]) -> float:
    return -float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def parabola(x: np.ndarray) -> np.ndarray:
    return x**2 / 2


def test_hertz_peak_pressure_converges_with_the_square_of_the_element() -> None:
    """Elements that end where the contact does. Measured: 3e-5 with 128 of them, order 1.99."""
    sizes = (20, 40, 80, 160)
    found = [dense_grid.solve(parabola, (-1.25, 1.25), count, F, [P], [0.0]) for count in sizes]
    assert [one.step * np.sum(one.pressure) for one in found] == pytest.approx([P] * 4, rel=1e-12)
    errors = [abs(one.pressure.max() / 0.5 - 1) for one in found]
    assert errors[-1] < 5e-5
    assert 1.8 < order(sizes, errors) < 2.2


def mindlin(count: int, steps: int, friction: float = F) -> float:
    """Dissipation of Q between +-0.6 f P at constant P, over the closed form."""
    up = np.linspace(0, 1, steps + 1)[1:]
    cycle = np.concatenate([1 - 2 * up, 2 * up - 1])
    shear = K * F * P * np.concatenate([[0.0], up, cycle, cycle])
    found = dense_grid.solve(parabola, (-1.25, 1.25), count, friction, np.full(len(shear), P), shear)
    exact = 4 * F**2 * P**2 / math.pi * ((1 - K) * math.log(1 - K) + K - K**2 / 2)
    return found.cycle_work(len(cycle))[-1] / exact


def test_mindlin_dissipation_converges() -> None:
    """Increments as long as elements. Where a stick edge falls within an element makes single errors jump: the order is about 2."""
    sizes = (25, 50, 100, 200)
    errors = [abs(mindlin(count, count // 5) - 1) for count in sizes]
    assert errors[-1] < 1e-3
    assert 1.0 < order(sizes, errors) < 2.8


def test_long_increments_wrong_friction_and_sliding_are_seen() -> None:
    assert mindlin(200, 8) - 1 == pytest.approx(-0.016, abs=2e-3)  # long increments limit a fine grid
    assert mindlin(50, 20, friction=0.4) > 1.3  # Q/(f P) = 0.75 instead of 0.6
    with pytest.raises(ArithmeticError, match="all cells slip"):
        mindlin(25, 5, friction=0.29)


def on_grid(name: str, beta: float, cells: int = 100, increments: int = 20) -> tuple[float, float]:
    """W of the second cycle and its largest pressure, of a polygon of loads; the first line in equal steps of the half-width."""
    scene, part = load_scene(name), np.arange(1, increments + 1)[:, None] / increments
    modulus = 1 / sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (scene.material.lower, scene.material.upper))
    initial, end = scene.load.initial_loading, scene.load.initial_loading[-1]
    half = 1.15 * math.sqrt(4 * max(p for p, _ in initial) * scene.profile.radius / (math.pi * modulus))

    def along(*corners: tuple[float, float]) -> list[np.ndarray]:
        return [np.array(a) + part * np.subtract(b, a) for a, b in pairwise(corners)]

    cycle = along(end, *scene.load.cycle, end)
    loads = np.concatenate([part**2 * np.array(initial[0]), *along(*initial), *cycle, *cycle]).T
    extent, friction = (-half, half), scene.friction.coefficient
    given = {"modulus": modulus, "dundurs": beta}
    found = dense_grid.solve(lambda x: parabola(x) / scene.profile.radius, extent, cells, friction, *loads, **given)
    count = increments * len(cycle)
    return found.cycle_work(count)[-1], float(found.pressure[-count:].max())


def expected(name: str, engine: str, quantity: str = "dissipation") -> float:
    return next(one.value for one in load_scene(name).expected if (one.engine, one.quantity) == (engine, quantity))


@pytest.mark.parametrize(("name", "beta"), NAMES.items())
def test_unlike_bodies_are_what_the_scenes_expect(name: str, beta: float) -> None:
    """Measured on 100 elements: 0.34 % and 0.25 % of W with coupling, 0.02 % of the peak; coupling takes up to 6 %."""
    plain, _ = on_grid(name, 0.0)
    assert plain == pytest.approx(expected(name, "half-plane theory"), rel=5e-3)
    coupled, peak = on_grid(name, beta)
    assert coupled == pytest.approx(expected(name, "finite elements"), rel=5e-3)
    assert peak == pytest.approx(expected(name, "finite elements", "largest_pressure"), rel=1e-3)


@pytest.mark.parametrize("planted", [0.0, 2.0])
def test_wrong_coupling_is_seen(planted: float) -> None:
    _, peak = on_grid("unlike-beta-fifth", planted * 0.2, 50, 10)
    assert abs(peak / expected("unlike-beta-fifth", "finite elements", "largest_pressure") - 1) > 0.03


def pressed(beta: float, friction: float) -> ContactSolution:
    """A parabola under P = 3, R = E* = 1, on bodies of this Dundurs constant by FE; at 0.5 the lower one is rigid."""
    sides = {"upper": 1 + 2 * beta, "lower": max(1 - 2 * beta, 1e-9)}
    material = {side: {"young_modulus": 2 / share, "poisson_ratio": 0.0} for side, share in sides.items()}
    load = {"kind": "polygon", "initial_loading": [(3.0, 0.0)]}
    keys = {"profile": {"kind": "hertz", "radius": 1.0}, "material": material, "friction": friction, "load": load}
    return halfplane_fe.solve(Scene.model_validate(keys), MeshSettings.coarse())


@pytest.mark.parametrize(
    ("ratio", "share", "within"), [(0.5, 0.9851714310094, 5e-3), (1, math.sqrt(0.5), 0.04), (2, 3 - 2 * math.sqrt(2), 0.08)]
)
def test_the_stick_zone_under_a_normal_load_is_that_of_goodmans_closed_solution(ratio: float, share: float, within: float) -> None:
    """c/a by beta/f; 0.3, 3 and 7 % of a were measured on the coarse mesh. Like bodies would stick all over."""
    found = pressed(0.01, 0.01 / ratio)
    assert np.ptp(found.stick_edges[-1]) / np.ptp(found.contact_edges[-1]) == pytest.approx(share, abs=within)


@pytest.mark.parametrize(("beta", "load"), [(0.1, 1.0074974191), (0.2, 1.0309017851), (0.3, 1.0732603237), (0.5, 1.2464188563)])
def test_the_load_of_a_bonded_contact_is_that_of_its_closed_solution(beta: float, load: float) -> None:
    """P over that of Hertz for the same half-width where nothing slips; 0.3 to 1.5 % were measured on the coarse mesh."""
    found = pressed(beta, 100.0)
    assert 48 / (math.pi * np.ptp(found.contact_edges[-1]) ** 2) == pytest.approx(load, abs=0.02 if beta == 0.5 else 5e-3)
