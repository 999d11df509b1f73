"""The naive peer of the benchmarks: right answers, of the order that it claims and of no other."""

from __future__ import annotations

import importlib
import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
P, F, K = math.pi / 4, 0.5, 0.6  # E* = R = a = 1


@pytest.fixture
def peer(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("discretised_half_plane")


def slope(sizes: tuple[int, ...], errors: list[float]) -> float:
    return -float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def test_hertz_peak_pressure_converges_with_the_square_of_the_element(peer: ModuleType) -> None:
    """Elements that end where the contact does. Measured: 3e-5 with 128 of them, order 1.99."""
    sizes, errors = (20, 40, 80, 160), []
    for count in sizes:
        on = peer.grid(1.25, count, 1.0)
        pressure = peer.press(on, peer.hertz_gap(1.0)(on.x), P, np.ones(count, dtype=bool))
        assert on.length * np.sum(pressure) == pytest.approx(P, rel=1e-12)
        errors.append(abs(pressure.max() / 0.5 - 1))
    assert errors[-1] < 5e-5
    assert 1.8 < slope(sizes, errors) < 2.2


def mindlin(peer: ModuleType, count: int, steps: int, friction: float = F) -> float:
    """Dissipation of Q between +-0.6 f P at constant P, over the closed form."""
    on = peer.grid(1.25, count, 1.0)
    up = np.linspace(0, 1, steps + 1)[1:]
    initial_loading = [(P, 0.0), *((P, K * F * P * part) for part in up)]
    cycle = [*((P, K * F * P * (1 - 2 * part)) for part in up), *((P, K * F * P * (2 * part - 1)) for part in up)]
    exact = 4 * F**2 * P**2 / math.pi * ((1 - K) * math.log(1 - K) + K - K**2 / 2)
    return peer.dissipation(on, peer.hertz_gap(1.0), initial_loading, cycle, friction)[0] / exact


def test_mindlin_dissipation_converges(peer: ModuleType) -> None:
    """Increments as long as elements. Where a stick edge falls within an element makes single errors jump: the order is about 2."""
    sizes = (25, 50, 100, 200)
    errors = [abs(mindlin(peer, count, count // 5) - 1) for count in sizes]
    assert errors[-1] < 1e-3
    assert 1.0 < slope(sizes, errors) < 2.8


def test_long_increments_are_what_limits_a_fine_grid(peer: ModuleType) -> None:
    assert mindlin(peer, 200, 8) - 1 == pytest.approx(-0.016, abs=2e-3)


def test_less_friction_is_seen(peer: ModuleType) -> None:
    """Q/(f P) = 0.75 instead of 0.6: more slips, more is lost."""
    assert mindlin(peer, 50, 20, friction=0.4) > 1.3


def test_what_slides_altogether_is_refused(peer: ModuleType) -> None:
    with pytest.raises(peer.NotSolvedError):
        mindlin(peer, 25, 5, friction=0.29)
