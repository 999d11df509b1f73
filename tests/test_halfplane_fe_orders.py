"""Observed orders of p, q, a, c and W over the paper's cycle under uniform refinement, and their class; asserted on both sides."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
fe_orders = importlib.import_module("fe_orders")
sys.path.remove(str(BENCHMARKS))

CUTS = (8, 16, 32)


def within(found: float, order: int, name: str) -> bool:
    return abs(found - fe_orders.EXPECTED[order][name]) <= fe_orders.ROOM


def sequence(cuts: tuple[int, ...], order: int, name: str) -> list[float]:
    spread = fe_orders.SPREAD if name == "W" else fe_orders.SPREAD[::3]
    return [fe_orders.rung(n, order, spread)[name] for n in cuts]


@pytest.mark.parametrize("name", ["p", "q", "a", "c", pytest.param("W", marks=pytest.mark.slow)])
def test_quadratic_elements_converge_at_their_order(name):
    found = sequence(CUTS, 2, name)
    assert fe_orders.convergence_class(found) == "monotone", found
    assert within(fe_orders.observed_order(CUTS, found), 2, name), found


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", fe_orders.QUANTITIES)
def test_finer_ladder(name, order):
    found = sequence((16, 32, 64), order, name)
    assert fe_orders.convergence_class(found) == "monotone", found
    assert within(fe_orders.observed_order((16, 32, 64), found), order, name), found


@pytest.mark.parametrize(
    ("fault", "name"),
    [(0.02, "p"), (0.05, "q"), (0.01, "a"), (0.03, "c")],
)
def test_a_floor_under_the_error_is_seen(fault, name):
    """The measured sequence with a constant added falls too slowly."""
    found = [error + fault for error in sequence(CUTS, 2, name)]
    assert not within(fe_orders.observed_order(CUTS, found), 2, name)


@pytest.mark.parametrize("name", fe_orders.QUANTITIES)
def test_too_fast_is_as_suspect_as_too_slow(name):
    for planted in (0.2, 2.5):
        found = [n**-planted for n in CUTS]
        assert fe_orders.observed_order(CUTS, found) == pytest.approx(planted)
        assert not within(planted, 2, name)


@pytest.mark.parametrize(
    ("errors", "kind"),
    [
        ([4.0, 2.0, 1.0], "monotone"),
        ([-4.0, -2.0, -1.0], "monotone"),
        ([4.0, -2.0, 1.0], "oscillating"),
        ([4.0, 1.0, 2.0], "oscillating"),
        ([1.0, 0.1, -2.0], "diverging"),
        ([1.0, 1.0, 1.0], "diverging"),
        ([1.0, 0.5, float("nan")], "diverging"),
    ],
)
def test_classes(errors, kind):
    assert fe_orders.convergence_class(errors) == kind
