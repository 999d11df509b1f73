"""Laws of the maps: order and constant recovered, intervals honest, a wrong order found out."""

from __future__ import annotations

import numpy as np
import pytest

from reports.maps import fit_law
from reports.maps.fitting import Line
from reports.maps.limits import bound

S = np.geomspace(0.02, 0.3, 9)
U = np.full(9, 1e-3)


def drawn(order: float, constant: float, seed: int, shared: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Errors of a law with its next term, and independent and shared errors of the stated size."""
    random = np.random.default_rng(seed)
    u = 1e-3 * np.ones_like(S)
    return constant * S**order * (1 - 0.8 * S**2) + u * (0.5 * random.standard_normal(len(S)) + shared), u


@pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
def test_order_and_constant_are_recovered(order: float) -> None:
    law = fit_law(S, -3 * S**order, 1e-6 * np.ones(9), order)
    assert law is not None
    assert law.sign == -1
    assert law.order == pytest.approx(order, abs=1e-3)
    assert law.fixed == pytest.approx(3, rel=1e-3)
    assert law.agrees()


def test_intervals_hold_the_truth() -> None:
    """Independent errors of u/2 and a shared one of up to u: the truth is in nearly every interval."""
    held = {"order": 0, "constant": 0}
    for seed in range(200):
        shared = np.random.default_rng(1000 + seed).uniform(-0.7, 0.7)
        error, u = drawn(2.0, 3.0, seed, shared)
        law = fit_law(S, error, u, 2.0)
        assert law is not None
        held["order"] += law.agrees()
        held["constant"] += abs(law.fixed - 3) <= law.fixed_doubt
    assert min(held.values()) >= 190  # measured: 200 and 199


@pytest.mark.parametrize("wrong", [1.0, 3.0])
def test_a_wrong_order_is_found_out(wrong: float) -> None:
    error, u = drawn(2.0, 3.0, seed=1)
    law = fit_law(S, error, u, wrong)
    assert law is not None
    assert not law.agrees()


def test_unresolved_points_take_no_part() -> None:
    error = 3 * S**2
    u = np.where(S < 0.05, 1.0, 1e-5)
    law = fit_law(S, error, u, 2.0)
    assert law is not None
    assert law.smallest > 0.05


def test_points_beyond_the_asymptotic_range_are_left_out() -> None:
    s = np.geomspace(0.01, 1.0, 12)
    error = 2 * s**2 / (1 + (2 * s) ** 4) ** 0.5
    law = fit_law(s, error, 1e-3 * error, 2.0)
    assert law is not None
    assert law.left_out > 0
    assert law.largest < 0.7
    assert law.order == pytest.approx(2.0, abs=max(law.order_doubt, 0.02))


def test_too_few_points_make_no_law() -> None:
    assert fit_law(S[:4], 3 * S[:4] ** 2, 1e-6 * np.ones(4), 2.0) is None
    assert fit_law(S, 1e-4 * S**2, U, 2.0) is None


def test_from_a_change_of_sign_on_nothing_is_fitted() -> None:
    error = 2 * S**2 * (1 - (S / 0.2) ** 4)
    law = fit_law(S, error, 1e-4 * np.abs(error), 2.0)
    assert law is None or law.largest < 0.2


def test_a_bound_counts_the_uncertainty() -> None:
    line = Line("error.dissipation", {}, S, 3 * S**2, np.zeros(9), None)
    doubtful = Line("error.dissipation", {}, S, 3 * S**2, 0.5 * 3 * S**2, None)
    found, safe = bound(line, 0.03), bound(doubtful, 0.03)
    assert found.s == pytest.approx(0.1, rel=1e-6)
    assert safe.s == pytest.approx(0.1 / np.sqrt(1.5), rel=1e-6)
    assert bound(line, 1.0).how == "all"
    assert bound(line, 1e-6).s is None
