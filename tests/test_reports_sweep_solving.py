"""What a worker answers: the engines' own figures, shared bodies that move none, uncertainties that cover, failures in words."""

import json
import math
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from markupsafe import escape

import semi_analytic
from halfplane_fe import SolverSettings
from halfplane_fe import solve as solve_fe
from meshes import MeshSettings
from reports.cli import main
from reports.comparison import compare
from reports.sweep.evaluating import _scales_of
from reports.sweep.index import read_index
from reports.sweep.page import write_page
from reports.sweep.points import expand
from reports.sweep.solving import solve_task
from reports.sweep.store import Store
from reports.sweep.study import Study, study_of
from reports.sweep.versions import code_versions, task_modules
from scenes import ConvergenceError, InputError, load_scene
from scenes.files import source_digest
from test_reports_sweep_study import study

ROOT = Path(__file__).parents[1]
COARSE = {
    "mesh.element_size": 0.25,
    "mesh.edge_element_size": 0.125,
    "mesh.order": 1,
    "mesh.growth": 1.0,
    "solver.steps_per_cycle": 24,
}
MESH = MeshSettings(element_size=0.25, edge_element_size=0.125, order=1, growth=1.0)
SOLVER = SolverSettings(steps_per_cycle=24)


def answers(asked: Study) -> list[dict[str, Any]]:
    task = {
        "versions": code_versions(),
        "engines": asked.engines,
        "figures": asked.figures,
        "uncertainty": asked.uncertainty,
        "share": asked.share_condensations,
        "points": [point.job() for point in expand(asked)],
    }
    found: list[dict[str, Any]] = json.loads(solve_task(json.dumps(task)))["answers"]
    return found


def fe_study(**changes: Any) -> Study:
    return study(scene="blocks", engines=["fe", "exact"], preset="default", **({"set": COARSE} | changes))


def test_the_figures_are_those_of_the_engines() -> None:
    axes = [{"name": "f", "key": "friction.coefficient", "values": [1.0]}]
    figures = ["error.dissipation", "fe.peak_pressure", "exact.permanent_stick_half_width", "stick_edge"]
    [answer] = answers(fe_study(axes=axes, figures=figures, share_condensations=False))
    scene = load_scene("blocks")
    fe = solve_fe(scene, MESH, SOLVER)
    exact = semi_analytic.solve(scene, x=fe.x, time=fe.time)
    expected = {
        "error.dissipation": fe.dissipation / exact.dissipation - 1,
        "fe.peak_pressure": float(fe.pressure[fe.last_cycle].max()),
        "exact.permanent_stick_half_width": exact.permanent_stick_half_width,
        "stick_edge": compare(exact, fe).metric("stick_edge").value,
    }
    assert answer["figures"] == expected
    assert answer["record"]["converged"]


def test_an_answer_is_the_same_alone_and_in_company() -> None:
    axis = {"name": "f", "key": "friction.coefficient"}
    figures = ["error.dissipation", "error.permanent_stick_half_width"]
    alone = answers(fe_study(axes=[axis | {"values": [1.5]}], figures=figures))
    together = answers(fe_study(axes=[axis | {"values": [0.9, 1.5, 3.0]}], figures=figures))
    assert together[1]["figures"] == alone[0]["figures"]
    assert together[1]["address"] == alone[0]["address"]


def test_points_that_share_their_bodies_condense_them_once() -> None:
    axes = [{"name": "f", "key": "friction.coefficient", "values": [1.0, 1.5, 2.0]}]
    _scales_of.cache_clear()
    found = answers(fe_study(axes=axes, figures=["fe.dissipation"]))
    assert _scales_of.cache_info().misses == 1  # and one coarse run for all
    assert [answer["record"]["counts"]["condensations"] for answer in found] == [1, 0, 0]
    own = answers(fe_study(axes=axes, figures=["fe.dissipation"], share_condensations=False))
    for shared, single in zip(found, own, strict=True):  # another mesh of the same size: coarse, so a few per cent
        assert shared["figures"]["fe.dissipation"] == pytest.approx(single["figures"]["fe.dissipation"], rel=0.03)


def test_a_cheap_uncertainty_covers_the_error_of_half_planes() -> None:
    """Between half-planes the error is that of the mesh, the steps and the far field: known, for theory has none."""
    axes = [{"name": "f", "key": "friction.coefficient", "values": [1.0, 2.0]}]
    figures = ["error.dissipation", "error.p0", "error.contact_half_width", "exact.dissipation"]
    found = answers(
        study(
            engines=["fe", "exact"],
            axes=axes,
            figures=figures,
            uncertainty="cheap",
            set={"solver.steps_per_cycle": 48},
            preset="coarse",
        )
    )
    for answer in found:
        assert "exact.dissipation.uncertainty" not in answer["figures"]
        for name in figures[:3]:
            assert 0 < abs(answer["figures"][name]) <= answer["figures"][f"{name}.uncertainty"], name


def test_one_call_gives_what_solving_one_by_one_gives() -> None:
    axes = [
        {"name": "f", "key": "friction.coefficient", "linear": {"start": 0.9, "stop": 2, "count": 5}},
        {"name": "phase", "key": "load.phase_degrees", "values": [-120.0, 45.0, 90.0]},
    ]
    at_once = answers(study(axes=axes, set={"load.initial_loading": "straight", "load.mean_tangential_load": 0.0}))
    assert {answer["record"]["message"] for answer in at_once} == {"a member of a batch"}
    singly = answers(
        study(
            axes=axes,
            set={"load.initial_loading": "straight", "load.mean_tangential_load": 0.0},
            figures=["exact.dissipation", "exact.loop_work"],
        )
    )
    assert len(at_once) == len(singly) == 15
    for one, other in zip(at_once, singly, strict=True):
        assert one["figures"]["exact.dissipation"] == pytest.approx(other["figures"]["exact.dissipation"], rel=1e-9)


@pytest.mark.parametrize("figures", [["exact.dissipation"], ["exact.dissipation", "exact.p0"]], ids=["in one call", "one by one"])
def test_neglected_coupling_is_noted_in_store_table_and_page(
    figures: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = tmp_path / "study.json"
    axes = [{"name": "E", "key": "material.lower.young_modulus", "values": [7e4, 210e3]}]
    asked.write_text(json.dumps({"scene": "hertz-paper", "axes": axes, "engines": ["exact"], "figures": figures}), encoding="utf-8")
    note = "Dundurs' beta = -0.142857: the bodies are unlike, and the coupling of normal and shear tractions is neglected"
    assert main(["sweep", str(asked), "--out", str(tmp_path / "out"), "--workers", "1", "--resume", "--quiet"]) == 0
    assert f"note on 1 of 2 points: {note}" in " ".join(capsys.readouterr().out.split())
    assert [row["notes"] for row in read_index(tmp_path / "out").rows] == [note, ""]
    assert f'"{note}"' in (tmp_path / "out" / "index.csv").read_text(encoding="utf-8")
    assert str(escape(note)) in write_page(Store(tmp_path / "out")).read_text(encoding="utf-8")
    assert main(["sweep", "status", str(tmp_path / "out"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["notes"] == [{"note": note, "points": 1}]


def test_coupling_that_theory_neglects_is_noted_beside_finite_elements() -> None:
    axes = [{"name": "E", "key": "material.lower.young_modulus", "values": [7e4]}]
    [answer] = answers(fe_study(axes=axes, figures=["error.dissipation"]))
    assert answer["status"] == "done", answer
    assert [note for note in answer["record"]["notes"] if note.startswith("half-plane theory: Dundurs' beta = -0.14")]


def test_what_does_not_converge_is_a_failure_with_its_record(monkeypatch: pytest.MonkeyPatch) -> None:
    partial = semi_analytic.solve(load_scene("cattaneo-mindlin"))

    def fails(*_: object) -> None:
        raise ConvergenceError("residual 0.3 after 100 iterations", partial)

    monkeypatch.setattr("reports.sweep.solving.finite_elements", fails)
    axes = [{"name": "f", "key": "friction.coefficient", "values": [1.0]}]
    [answer] = answers(fe_study(axes=axes, figures=["fe.dissipation"]))
    assert (answer["status"], answer["figures"]) == ("failed", {})
    assert answer["reason"] == "not converged: residual 0.3 after 100 iterations"
    assert answer["record"]["steps"] == len(partial.time)


def test_a_figure_that_is_not_there_says_why() -> None:
    [answer] = answers(study(figures=["exact.permanent_stick_half_width"], axes=[_nothing_sticks()], scene="cattaneo-mindlin"))
    assert answer["figures"] == {"exact.permanent_stick_half_width": None}
    assert "there is none" in answer["notes"]["exact.permanent_stick_half_width"]


def _nothing_sticks() -> dict[str, Any]:
    """|Q| = f P at the ends of the cycle: the stick zone has just closed."""
    scene = load_scene("cattaneo-mindlin")
    corners = [corner for corner in scene.load.model_dump()["cycle"] if corner[1]]
    return {"name": "f", "key": "friction.coefficient", "values": [abs(corners[0][1]) / corners[0][0]]}


def test_other_code_is_noticed_before_anything_is_solved() -> None:
    task = {"versions": code_versions() | {"numpy": "0.1"}, "points": []}
    assert re.search(r"numpy is 0\.1 here and .* there", json.loads(solve_task(json.dumps(task)))["mismatch"])


def modules_of_a_task() -> list[Path]:
    """Files of `reports` that a worker loads, listed by a process that loads them."""
    words = (
        "import sys, reports.sweep.solving, reports.comparison.budget\n"
        "print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('reports.') and n != 'reports.sweep'), sep='\\n')"
    )
    found = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True, cwd=ROOT).stdout
    return [Path(line) for line in found.split()]


def test_any_other_line_that_numbers_depend_on_is_another_address(monkeypatch: pytest.MonkeyPatch) -> None:
    engines = ("scenes", "semi_analytic", "meshes", "halfplane_fe")
    counted = [*(path for name in engines for path in sorted((ROOT / name).rglob("*.py"))), *modules_of_a_task()]
    assert {"metrics.py", "cycles.py", "budget.py", "laws.py", "evaluating.py"} <= {path.name for path in counted}
    read, edited = Path.read_bytes, Path()
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + (b"# one line more" if path == edited else b""))
    addresses = set()
    for edited in [Path(), *counted]:  # noqa: B007 (the reader looks at it)
        for cached in (source_digest, code_versions):
            cached.cache_clear()
        addresses.add(code_versions()["code"])
    for cached in (source_digest, code_versions):
        cached.cache_clear()
    assert len(addresses) == len(counted) + 1


@pytest.mark.parametrize("name", ["reports.gone", "gone", "reports.sweep.gone"])
def test_a_module_that_is_missing_has_no_digest(name: str) -> None:
    """Names that matched no file were passed over in silence."""
    with pytest.raises(InputError, match=f"^{name}: this installation lacks the module's source file"):
        source_digest(name)


def test_pages_are_no_part_of_an_address() -> None:
    assert not {"reports.page", "reports.notebook", "reports.comparison.words", "reports.cli"} & set(task_modules())


def test_the_study_of_the_docs_is_one() -> None:
    [text] = re.findall(
        r"^```toml\n(.*?)^```", (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
    )
    points = expand(study_of(tomllib.loads(text), "docs/sweeps.md"))
    assert len(points) == 8
    assert math.isclose(points[-1].scene.load.model_dump()["tangential_amplitude"], 25 + 16 / 10)
