"""The regression table of the half-plane engine: complete, good now, and able to fail in either column."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType

import pytest

from scenes import scene_names

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"


@pytest.fixture
def regress(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("regress")


def stored() -> dict[str, dict]:
    return json.loads((BENCHMARKS / "regress.json").read_text(encoding="utf-8"))


def test_every_scene_of_the_library_is_in_the_table_and_good(regress: ModuleType) -> None:
    lines = regress.lines(stored())
    assert {line.scene for line in lines} == set(scene_names())
    # Other processors round otherwise: the table itself asks for less than this test.
    assert not [line for line in lines if line.drift is None or line.drift > 1e-11 or (line.error or 0.0) > 1e-12]


def test_each_column_sees_its_own_fault_only(regress: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regress, "scene_names", lambda: ("hertz-paper",))
    table = stored()
    frozen = table["hertz-paper"]["frozen"]
    frozen["dissipation"] *= 1 + 1e-10
    drifted = {line.quantity: line for line in regress.lines(table)}["dissipation"]
    assert not drifted.good
    assert drifted.error is not None
    assert drifted.error < 1e-13
    assert drifted.drift == pytest.approx(1e-10, rel=1e-3)
    table = stored()
    table["hertz-paper"]["reference"] = "0.0020575001840"
    wrong = {line.quantity: line for line in regress.lines(table)}["dissipation"]
    assert not wrong.good
    assert wrong.drift == pytest.approx(0.0, abs=1e-11)
    assert wrong.error is not None
    assert wrong.error > 1e-11


def test_a_scene_that_is_new_is_not_good_until_it_is_accepted(regress: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regress, "scene_names", lambda: ("full-stick",))
    assert not any(line.good for line in regress.lines({}))
