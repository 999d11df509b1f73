"""The scored examples: their files are scored again, and the numbers and pages that they ship with say the same."""

from __future__ import annotations

import importlib.util
import json
import runpy
import sys
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import semi_analytic
from reports.comparison import Report
from reports.scoring.against import score_file
from reports.scoring.mapping import Mapping, Signs, load_mapping
from reports.scoring.reading import read
from scenes import load_scene

FOLDER = Path(__file__).parents[1] / "docs" / "examples" / "score"
_SPEC = importlib.util.spec_from_file_location("measure_examples", FOLDER / "measure.py")
assert _SPEC is not None
assert _SPEC.loader is not None
measure: Any = importlib.util.module_from_spec(_SPEC)
sys.modules["measure_examples"] = measure
_SPEC.loader.exec_module(measure)

SHIPPED = json.loads((FOLDER / "numbers.json").read_text("utf-8"))
EXAMPLES = {example.name: example for example in measure.EXAMPLES}


@cache
def scored(name: str) -> Report:
    return measure.scored(EXAMPLES[name])


@pytest.mark.parametrize(
    "name", [pytest.param("calculix", marks=pytest.mark.slow), "kratos", pytest.param("abaqus", marks=pytest.mark.slow)]
)
def test_an_example_scores_what_it_and_its_page_say(name: str) -> None:
    """Where a rule of the score was changed on purpose: python docs/examples/score/measure.py."""
    found, shipped = measure.numbers(scored(name)), SHIPPED[name]
    assert (found["diagnoses"], found["passed"]) == (shipped["diagnoses"], shipped["passed"])
    for key, value in shipped["metrics"].items():
        assert found["metrics"][key] == (value if value is None else pytest.approx(value, rel=1e-6, abs=1e-12)), key
    made = json.loads((FOLDER / name / "made.json").read_text("utf-8"))
    block = measure.MARKS.search((FOLDER / name / "README.md").read_text("utf-8"))
    assert block is not None
    assert block[0] == measure.told(scored(name), made)
    assert sum(file.stat().st_size for file in (FOLDER / name).iterdir()) < 1_000_000


def test_what_the_pages_say_of_the_results() -> None:
    assert set(SHIPPED) == set(EXAMPLES)
    calculix, kratos, abaqus = (SHIPPED[name] for name in ("calculix", "kratos", "abaqus"))
    assert calculix["diagnoses"][0] == "coarse_edge"
    assert kratos["diagnoses"] == ["unknown"]
    assert kratos["metrics"]["shear"] > 10 * calculix["metrics"]["pressure"]
    assert abaqus["metrics"]["dissipation"] is None
    assert not any(found["passed"] for found in SHIPPED.values())


def test_multipliers_of_kratos_add_up_to_the_loads() -> None:
    result = read(FOLDER / "kratos" / "result.csv", Mapping())
    for field, load in ((result.pressure, result.normal_load), (result.shear, result.tangential_load)):
        np.testing.assert_allclose(np.trapezoid(field, result.x, axis=1), load, atol=2e-4 * result.normal_load.max())


def test_report_and_table_of_the_path_score_alike_and_a_turned_shear_would_be_noticed() -> None:
    folder, scene = FOLDER / "abaqus", load_scene(measure.SCENE)
    mapping = load_mapping(folder / "mapping.toml")
    table, report = (score_file(folder / f"path.{suffix}", mapping, scene) for suffix in ("csv", "rpt"))
    assert measure.numbers(table)["metrics"] == measure.numbers(report)["metrics"]
    for key, value in SHIPPED["abaqus"]["metrics"].items():
        assert table.metric(key).value == (value if value is None else pytest.approx(value, rel=1e-6)), key
    wrong = score_file(folder / "path.csv", mapping.vary(signs=Signs(shear="on upper")), scene)
    assert wrong.metric("shear").value > 5 * table.metric("shear").value


def test_the_script_for_abaqus_writes_a_table_that_is_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a stand-in for Abaqus' own module, with two pairs, of which one is named, and slip that was not requested."""
    scene, x, times = load_scene("cattaneo-mindlin"), np.linspace(-1.2, 1.2, 41), (1.0, 1.5, 2.0)
    exact = semi_analytic.solve(scene, x=x, time=times, fields=("pressure", "shear"))
    block = SimpleNamespace(name="BLOCK-1", nodes=[SimpleNamespace(label=k, coordinates=(v, 0.0, 0.0)) for k, v in enumerate(x, 1)])

    def output(values: Any) -> Any:
        return SimpleNamespace(values=[SimpleNamespace(instance=block, nodeLabel=k, data=v) for k, v in enumerate(values, 1)])

    def frame(k: int) -> Any:
        own = {
            "CPRESS   ASSEMBLY_FACE/ASSEMBLY_PAD": output(exact.pressure[k]),
            "CSHEAR1  ASSEMBLY_FACE/ASSEMBLY_PAD": output(exact.shear[k]),
        }
        other = {"CPRESS   ASSEMBLY_BASE/ASSEMBLY_TABLE": output(0 * x), "U": output(x)}
        return SimpleNamespace(frameValue=times[k], fieldOutputs=own | other)

    odb = SimpleNamespace(
        rootAssembly=SimpleNamespace(instances={"BLOCK-1": block}),
        steps={"Step-1": SimpleNamespace(totalTime=0.0, frames=[frame(k) for k in range(3)])},
        close=lambda: None,
    )
    monkeypatch.setitem(sys.modules, "odbAccess", SimpleNamespace(openOdb=lambda path, readOnly: odb))
    script = runpy.run_path(str(FOLDER / "abaqus" / "odb_table.py"))
    with pytest.raises(
        ValueError, match="several contact pairs have CPRESS: name one of them, such as 'ASSEMBLY_BASE/ASSEMBLY_TABLE'"
    ):
        script["main"]("job.odb", str(tmp_path / "table.csv"))
    script["main"]("job.odb", str(tmp_path / "table.csv"), "face")
    found = read(tmp_path / "table.csv", Mapping())
    np.testing.assert_array_equal(found.pressure, exact.pressure)
    np.testing.assert_array_equal(found.shear, exact.shear)
    assert (found.time.tolist(), found.slip) == (list(times), None)
    assert score_file(tmp_path / "table.csv", Mapping(), scene).comparison.passed
