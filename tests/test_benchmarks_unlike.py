"""The coupled grid of unlike half-planes: Mindlin without coupling, what the scenes expect with it, and able to fail."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from scenes import load_scene

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
NAMES = {"unlike-beta-tenth": 0.1, "unlike-beta-fifth": 0.2}


@pytest.fixture
def peer(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("unlike_half_planes")


def expected(name: str, engine: str, quantity: str = "dissipation") -> float:
    return next(one.value for one in load_scene(name).expected if (one.engine, one.quantity) == (engine, quantity))


@pytest.mark.parametrize("name", NAMES)
def test_without_coupling_it_is_mindlin(peer: ModuleType, name: str) -> None:
    """On 100 elements and 20 increments 0.30 % were measured, on 400 and 80 0.007 %."""
    found = peer.solve(load_scene(name), 0.0, 100, 20)
    assert found.dissipation == pytest.approx(expected(name, "half-plane theory"), rel=5e-3)


@pytest.mark.parametrize(("name", "beta"), NAMES.items())
def test_with_coupling_it_is_what_the_scenes_expect(peer: ModuleType, name: str, beta: float) -> None:
    """On 100 elements 0.35 % of the dissipation, 0.02 % of the peak were measured; coupling takes 1.1 % and 6.2 % of the former."""
    found = peer.solve(load_scene(name), beta, 100, 20)
    assert found.dissipation == pytest.approx(expected(name, "finite elements"), rel=5e-3)
    assert found.peak == pytest.approx(expected(name, "finite elements", "largest_pressure"), rel=1e-3)


@pytest.mark.parametrize("planted", [0.0, 2.0])
def test_wrong_coupling_is_seen(peer: ModuleType, monkeypatch: pytest.MonkeyPatch, planted: float) -> None:
    right = peer.coupling
    monkeypatch.setattr(peer, "coupling", lambda on, beta, modulus: planted * right(on, beta, modulus))
    found = peer.solve(load_scene("unlike-beta-fifth"), 0.2, 100, 20)
    assert abs(found.peak / expected("unlike-beta-fifth", "finite elements", "largest_pressure") - 1) > 0.03


def test_the_mirror_image_is_the_same(peer: ModuleType) -> None:
    scene = load_scene("unlike-beta-fifth")
    both = [peer.solve(scene, beta, 60, 8) for beta in (0.2, -0.2)]
    assert np.ptp([found.dissipation for found in both]) < 1e-6 * both[0].dissipation
