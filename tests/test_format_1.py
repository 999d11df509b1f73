"""What version 0.1 wrote is read for good: fixtures of cattaneo-mindlin on a coarse mesh, frozen before format number 2."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

import semi_analytic
from command_line import halfplane, refused
from reports import compare
from reports.scoring.against import own_solution
from scenes import ContactSolution, load_scene

KEPT = Path(__file__).parent / "fixtures" / "format1"
DISSIPATION = 0.0011734782422501023  # of result.nc


def said(folder: Path, *words: str | Path) -> tuple[int, Any]:
    done = halfplane(folder, *map(str, words), "--json")
    return done.returncode, json.loads(done.stdout)["result"]


def test_a_solution_is_loaded_with_every_number() -> None:
    found = ContactSolution.load(KEPT / "result.nc")
    whole = json.loads((KEPT / "comparison.json").read_text(encoding="utf-8"))["result"]
    assert (found.engine, found.scene.name) == ("halfplane_fe", "cattaneo-mindlin")
    assert found.dissipation == whole["dissipation"] == pytest.approx(DISSIPATION, rel=1e-12)
    assert found.pressure.max() == pytest.approx(whole["largest_pressure"], rel=1e-15)
    assert found.record.converged


def test_a_later_format_is_refused_and_this_one_is_read(tmp_path: Path) -> None:
    """Before its variables are looked for: a later format may have others."""
    data = ContactSolution.load(KEPT / "result.nc").to_dataset()
    assert data.attrs["format"] == "halfplane solution 2"
    later = data.drop_vars("slip").assign_attrs(format="halfplane solution 3")
    for name, stored in (("two.nc", data), ("three.nc", later)):
        stored.to_netcdf(tmp_path / name, engine="h5netcdf")
    assert ContactSolution.load(tmp_path / "two.nc").dissipation == pytest.approx(DISSIPATION, rel=1e-15)
    line = refused(tmp_path, "diff", "three.nc", "two.nc")
    assert "three.nc: format is 'halfplane solution 3', of a later version" in line


def test_diff_reads_each_kind(tmp_path: Path) -> None:
    """A run, its baseline, one engine's summary and its NetCDF: of one solution, so no row differs."""
    for a, b in (("comparison.json", "baseline.json"), ("result.nc", "halfplane_fe.json"), ("comparison.json", "result.nc")):
        code, found = said(tmp_path, "diff", KEPT / a, KEPT / b)
        assert code == 0, (a, b)
        rows = {row["key"]: row for row in found["rows"]}
        assert rows["halfplane_fe.dissipation"]["a"] == pytest.approx(DISSIPATION, rel=1e-12)
        assert ("metric.shear" in rows) is (b == "baseline.json")
        assert all(row["difference"] in (0, None) for row in rows.values())


def test_a_solution_is_scored_against_theory() -> None:
    """The number of the run that wrote it."""
    scene = load_scene("cattaneo-mindlin")
    found = own_solution(KEPT / "result.nc", scene)
    comparison = compare(semi_analytic.solve(scene, x=found.x, time=found.time), found)
    before = json.loads((KEPT / "comparison.json").read_text(encoding="utf-8"))["metrics"]["dissipation"]["value"]
    assert comparison.metric("dissipation").value == pytest.approx(before, rel=1e-9)
    assert not comparison.passed


def test_a_store_of_a_sweep_is_left_alone_and_counted(tmp_path: Path) -> None:
    folder = shutil.copytree(KEPT / "sweep", tmp_path / "sweep")
    code, found = said(tmp_path, "sweep", "status", "sweep")
    assert (code, found["points"]["done"], found["points"]["total"], found["damaged"]) == (0, 2, 2, [])
    for file in (KEPT / "sweep" / "results").iterdir():
        assert (folder / "results" / file.name).read_bytes() == file.read_bytes()
