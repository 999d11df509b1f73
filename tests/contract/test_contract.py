"""The contract: values of both engines and of comparisons that a rebuild must not move.

`make contract` runs all of it, `make test` a part. The values are baselines and references of the
table of cases (`tests/cases`); `make cases` makes baselines again, by name.
"""

from __future__ import annotations

import json
from pathlib import Path

import case_table
import pytest
from contract_values import (
    COARSE,
    COMPARED,
    QUICK,
    coarse_values,
    comparison_metrics,
    contract_baselines,
    finite_elements,
    half_plane,
    scene_of,
    scenes_of,
)

HERE = Path(__file__).parent


def some(names, quick):
    return [name if name in quick else pytest.param(name, marks=pytest.mark.slow) for name in names]


@pytest.mark.parametrize("name", some(scenes_of(case_table.THEORY), QUICK))
def test_half_plane_theory_gives_the_baselines_and_the_references(name: str) -> None:
    known = case_table.sheet(name)
    now = half_plane(scene_of(name), dict(known.points))
    baselines = contract_baselines(known)
    assert baselines
    assert not case_table.moved(baselines, now)
    missed = [
        case
        for case in known.references(case_table.THEORY)
        if case.key in now and not case_table.agrees(case, now[case.key])
    ]
    assert not missed


@pytest.mark.parametrize(
    "name", some(scenes_of(COARSE), ("cattaneo-mindlin", "flat-rounded-paper", "blocks"))
)
def test_finite_elements_give_the_baselines(name: str) -> None:
    baselines = case_table.sheet(name).baselines(COARSE)
    assert not case_table.moved(baselines, coarse_values(finite_elements(name)))


@pytest.mark.parametrize("name", some(scenes_of(COMPARED), ("cattaneo-mindlin", "blocks")))
def test_comparisons_give_the_baselines(name: str, tmp_path: Path) -> None:
    baselines = case_table.sheet(name).baselines(COMPARED)
    metrics = comparison_metrics(name, tmp_path / "out")
    values = {(COMPARED, key, ""): metric["value"] for key, metric in metrics.items()}
    assert not case_table.moved(baselines, values)
    for case in baselines.values():
        assert case.more == {key: metrics[case.quantity][key] for key in ("unit", "accurate")}


def test_every_planted_fault_of_the_list_still_has_its_test() -> None:
    rows = json.loads((HERE / "planted_faults.json").read_text(encoding="utf-8"))
    for row in rows:
        file, test = row["test"].split("::")
        text = (HERE.parent / file).read_text(encoding="utf-8")
        assert f"def {test}(" in text, (
            f"{row['fault']}: {row['test']} is gone; what found the fault now belongs into"
            " planted_faults.json"
        )
    assert len(rows) >= 60
