"""The table of planted faults: each is caught by the checks that it names, and the healthy model trips none."""

from __future__ import annotations

import functools
import importlib
from pathlib import Path
from types import ModuleType

import pytest

from problems import COARSE

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
FAULTS = (
    *(
        "gap off by h/10 everywhere",
        "gap off by h/10 at mid-side nodes",
        "profile off by h/10 along x",
        "penalty too soft (1 E*/h)",
    ),
    *("steps too long (8 a revolution)", "the same, and no event landed on", "history dropped", "sign of Q flipped"),
    *(
        "friction 3 % low",
        "friction 3 % high",
        "slip recorded 1 % short",
        "pressure of sliding nodes 1 % short",
        "far field by halves",
    ),
)


@pytest.fixture
def table(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("must_fail")


@functools.cache
def on_a_coarse_mesh(table: ModuleType) -> dict[str, float]:
    return table.figures(table.solved(None, COARSE))


def caught(table: ModuleType, fault: object, mesh: object = None) -> set[str]:
    answer = table.solved(fault, mesh)
    found = dict.fromkeys(table.LIMITS, float("inf")) if isinstance(answer, str) else table.figures(answer)
    return {name for name, limit in table.LIMITS.items() if not found[name] <= limit}


def test_every_fault_of_the_list_is_in_the_table_and_names_checks_that_exist(table: ModuleType) -> None:
    assert tuple(fault.name for fault in table.FAULTS) == FAULTS
    assert all(fault.caught_by and set(fault.caught_by) <= set(table.LIMITS) for fault in table.FAULTS)


@pytest.mark.parametrize("name", ["history dropped", "pressure of sliding nodes 1 % short"])
def test_faults_are_caught_on_a_coarse_mesh_too(table: ModuleType, name: str) -> None:
    """What needs no reference has one limit on any mesh; against theory, shear is off by more than a coarse mesh costs."""
    (fault,) = (fault for fault in table.FAULTS if fault.name == name)
    healthy = on_a_coarse_mesh(table)
    broken = table.figures(table.solved(fault, COARSE))
    for check in fault.caught_by:
        assert broken[check] > max(table.LIMITS[check], 1.5 * healthy[check]), check
    for check in ("laws of contact", "energy balance", "overlap of the faces", "creep"):
        assert healthy[check] <= table.LIMITS[check]


@pytest.mark.slow
def test_the_healthy_model_passes_every_check(table: ModuleType) -> None:
    assert caught(table, None) == set()


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_is_caught_by_the_checks_that_it_names(table: ModuleType, name: str) -> None:
    (fault,) = (fault for fault in table.FAULTS if fault.name == name)
    assert set(fault.caught_by) <= caught(table, fault)


@pytest.mark.slow
def test_every_check_is_tripped_by_some_fault(table: ModuleType) -> None:
    assert set().union(*(caught(table, fault) for fault in table.FAULTS)) == set(table.LIMITS)
