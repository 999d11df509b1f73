"""Half-plane theory with a quadratic part more, and the known layers that it is tried on."""

from __future__ import annotations

import numpy as np
import pytest

import layer_truth
import semi_analytic
from reports.maps.layers import curvature_sum, response
from reports.maps.quadratic import Curvatures, dissipation, dissipation_error, ellipse_path
from scenes import EllipseLoad, load_scene

PAPER = ellipse_path(1 / 3, 1.1 / 3, 1 / 3, np.pi / 2)
NOTHING = Curvatures(0.0, 0.0)


def scaled(scene: object, value: float) -> float:
    """A dissipation over A P0^2/pi."""
    material, load = scene.material, scene.load  # type: ignore[attr-defined]
    compliance = sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (material.lower, material.upper))
    return value * np.pi / (2 * compliance * load.mean_normal_load**2)


@pytest.mark.parametrize("name", ["hertz-paper", "phase-45", "near-sliding"])
def test_without_bodies_it_is_half_plane_theory(name: str) -> None:
    scene = load_scene(name)
    load = scene.load
    assert isinstance(load, EllipseLoad)
    p0 = load.mean_normal_load
    p, q, cycle = ellipse_path(
        load.normal_amplitude / p0, load.mean_tangential_load / p0, load.tangential_amplitude / p0, load.phase
    )
    found = dissipation(p, q, scene.friction.coefficient, NOTHING, cycle)
    exact = scaled(scene, semi_analytic.solve(scene, fields=("dissipation",)).dissipation)
    assert found == pytest.approx(exact, rel=1e-3)  # measured 1e-4, 2e-4 and 6e-5: chords of the loop, cells of the memory


def test_a_stiffer_gap_alone_is_half_plane_theory_of_another_radius() -> None:
    """tau = 0, constant P: half-plane theory of the radius R/(1 + nu); W of Hertz does not depend on R."""
    q = 0.5 * np.interp(np.arange(801), [0, 200, 400, 600, 800], [1, 0, -1, 0, 1])
    p, q = np.concatenate([[0.5], np.ones(801 * 2)]), np.concatenate([[0.25], q, q])
    plain, stiff = (dissipation(p, q, 0.9, added, 800) for added in (NOTHING, Curvatures(0.2, 0.0)))
    assert stiff == pytest.approx(plain, rel=1e-3)


def test_a_tangential_part_moves_it_at_first_order() -> None:
    errors = [dissipation_error(*PAPER[:2], 1.0, Curvatures(0.0, tau), PAPER[2]) for tau in (0.02, 0.04)]
    assert errors[0] < -0.01
    assert errors[1] / errors[0] == pytest.approx(2.0, rel=0.05)


def test_mirror_of_the_loads_changes_nothing() -> None:
    added, (p, q, cycle) = Curvatures(0.03, 0.05), PAPER
    assert dissipation(p, -q, 1.0, added, cycle) == pytest.approx(dissipation(p, q, 1.0, added, cycle), rel=1e-12)


def test_layers_agree_with_the_known_solution() -> None:
    """p0 on a layer, half-width from Fourier integrals: N/4 for one body, for the other is rigid and its share of E* is all."""
    height, errors = 12.0, []
    layer = layer_truth.Layer(1.0, 0.3, height, 100.0)
    load = layer_truth.load_on(layer, 1.0)
    plane = 1 / (1 - 0.3**2)
    half_plane = np.sqrt(4 * load * 100.0 / (np.pi * plane))
    errors.append(1 / half_plane - 1)
    peak = float(layer_truth.pressure(layer, 1.0, np.array([0.0]))[0]) / (2 * load / (np.pi * half_plane)) - 1
    constant = -curvature_sum("fixed") / 4
    assert peak * height**2 == pytest.approx(constant, rel=0.02)  # measured 0.3 %
    assert errors[0] * height**2 == pytest.approx(-constant, rel=0.05)


@pytest.mark.parametrize("base", ["fixed", "rollers"])
@pytest.mark.parametrize("tangential", [False, True])
def test_deep_layers_are_half_planes_and_wide_blocks_are_layers(base: str, tangential: bool) -> None:
    assert response(base, tangential, 0.3)(np.array([20.0])) == pytest.approx(1.0, abs=1e-12)  # type: ignore[arg-type]
    if base == "rollers":
        wide = curvature_sum("rollers", tangential=tangential, aspect=60.0)
        assert wide == pytest.approx(curvature_sum("rollers", tangential=tangential), rel=2e-3)


def test_full_stick_has_no_relative_error() -> None:
    t = np.linspace(0, 4 * np.pi, 401)
    p, q = 1 + 0.3 * np.cos(t), 0.1 * (1 + 0.3 * np.cos(t))
    assert np.isnan(dissipation_error(p, q, 0.9, Curvatures(0.01, 0.0), 200))
