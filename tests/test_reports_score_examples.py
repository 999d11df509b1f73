"""The scored examples: their files are scored again, and the numbers and pages that they ship with say the same."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from reports.scoring.against import score_file
from reports.scoring.mapping import Mapping, Signs, load_mapping
from reports.scoring.reading import read
from scenes import load_scene

FOLDER = Path(__file__).parents[1] / "docs" / "examples" / "score"
_SPEC = importlib.util.spec_from_file_location("measure_examples", FOLDER / "measure.py")
assert _SPEC is not None
assert _SPEC.loader is not None
measure = importlib.util.module_from_spec(_SPEC)
sys.modules["measure_examples"] = measure
_SPEC.loader.exec_module(measure)

SHIPPED = json.loads((FOLDER / "numbers.json").read_text("utf-8"))
EXAMPLES = {example.name: example for example in measure.EXAMPLES}


@pytest.fixture(scope="module")
def scored():
    return {name: measure.scored(example) for name, example in EXAMPLES.items()}


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_scores_what_it_says(name, scored):
    found, shipped = measure.numbers(scored[name]), SHIPPED[name]
    # Where a rule of the score was changed on purpose: python docs/examples/score/measure.py
    assert found["diagnoses"] == shipped["diagnoses"]
    assert found["passed"] is shipped["passed"]
    for key, value in shipped["metrics"].items():
        assert found["metrics"][key] == (value if value is None else pytest.approx(value, rel=1e-6, abs=1e-12)), key


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_page_of_an_example_has_these_numbers(name, scored):
    made = json.loads((FOLDER / name / "made.json").read_text("utf-8"))
    block = measure.MARKS.search((FOLDER / name / "README.md").read_text("utf-8"))
    assert block is not None
    assert block[0] == measure.told(scored[name], made)


def test_what_the_pages_say_of_the_results(scored):
    calculix, kratos, abaqus = (scored[name] for name in ("calculix", "kratos", "abaqus"))
    assert [one.fault for one in calculix.diagnoses][:1] == ["coarse_edge"]
    assert [one.fault for one in kratos.diagnoses] == ["unknown"]
    assert kratos.metric("shear").value > 10 * calculix.metric("pressure").value
    assert abaqus.metric("dissipation").value is None
    assert not any(comparison.passed for comparison in scored.values())


@pytest.mark.parametrize("name", ["pressure", "shear"])
def test_multipliers_of_kratos_add_up_to_the_loads(name):
    result = read(FOLDER / "kratos" / "result.csv", Mapping(), load_scene(measure.SCENE))
    load = result.normal_load if name == "pressure" else result.tangential_load
    sums = np.trapezoid(getattr(result, name), result.x, axis=1)
    np.testing.assert_allclose(sums, load, atol=2e-4 * result.normal_load.max())


def test_report_and_table_of_the_path_score_alike(scored):
    mapping = load_mapping(FOLDER / "abaqus" / "mapping.toml")
    table = score_file(FOLDER / "abaqus" / "path.csv", mapping, load_scene(measure.SCENE))
    assert measure.numbers(table)["metrics"] == measure.numbers(scored["abaqus"])["metrics"]


def test_a_turned_shear_would_be_noticed(scored):
    folder = FOLDER / "abaqus"
    turned = load_mapping(folder / "mapping.toml").vary(signs=Signs(shear="on upper"))
    wrong = score_file(folder / "path.csv", turned, load_scene(measure.SCENE))
    assert wrong.metric("shear").value > 5 * scored["abaqus"].metric("shear").value


def test_an_example_is_small():
    for name in EXAMPLES:
        assert sum(file.stat().st_size for file in (FOLDER / name).iterdir()) < 1_000_000, name
