"""Faults planted in either engine: seen by a metric, and the right term of the error budget blamed."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

from reports.comparison.budget import Budget, Term
from reports.comparison.metrics import METRICS, Metric

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
blame = importlib.import_module("budget")
sys.path.remove(str(BENCHMARKS))


def found(value: float, *terms: Term) -> blame.Found:
    one = Budget(Metric(definition=METRICS["dissipation"], value=value), terms, half_planes=True)
    return blame.Found({"dissipation": value, blame.STEP: 0.0}, {"dissipation": one})


def mesh(value: float | None, uncertainty: float) -> Term:
    return Term("mesh", value, uncertainty, "planted")


SOLVER = Term("solver", None, 1e-12, "planted", bound=True)
HEALTHY = found(1e-3, mesh(0.9e-3, 0.2e-3), SOLVER)


def test_a_metric_within_its_band_sees_nothing():
    assert blame.seen(HEALTHY, HEALTHY) == {}
    assert blame.seen(found(1.1e-3, mesh(1e-3, 0.2e-3), SOLVER), HEALTHY) == {}


@pytest.mark.parametrize(
    ("faulty", "blamed"),
    [
        (found(1e-2, mesh(1e-3, 0.2e-3), SOLVER), "model"),
        (found(1e-2, mesh(0.9e-2, 2e-3), SOLVER), "mesh"),
        (found(1e-2, mesh(None, 2e-2), SOLVER), "mesh"),
        (found(1e-2, mesh(1e-3, 0.2e-3), Term("solver", None, 0.5, "planted", bound=True)), "solver"),
    ],
)
def test_blamed_is_what_is_large_and_the_model_only_beyond_doubt(faulty, blamed):
    assert list(blame.seen(faulty, HEALTHY)) == ["dissipation"]
    assert faulty.blamed("dissipation") == blamed


def test_steps_are_a_metric_by_themselves():
    long = blame.Found({blame.STEP: -1e-2}, {})
    assert blame.seen(long, blame.Found({blame.STEP: -1e-4}, {})) == {blame.STEP: pytest.approx(50.0)}
    assert long.blamed(blame.STEP) == "step"


@pytest.mark.slow
def test_every_planted_fault_is_seen_and_blamed_on_the_right_term(monkeypatch):
    monkeypatch.setenv("HALFPLANE_CACHE", "off")
    rows = list(blame.blame())
    assert len(rows) == 1 + len(blame.FAULTS)
    assert [row.what for row in rows if row.kept is not True] == []
