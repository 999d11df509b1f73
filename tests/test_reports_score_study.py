"""A folder of results: orders of planted errors are found, on both sides, and what no mesh removes is told apart from them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from reports.console import Stages
from reports.scoring.against import score_surface
from reports.scoring.mapping import Mapping
from reports.scoring.study import Level, element_size, study
from reports.scoring.study_files import results_in, score_folder
from reports.scoring.surface import surface_result
from scenes import InputError
from score_results import exact, rows, written

POINTS = (27, 53, 105, 209)


def _level(points, order, amount, rest):
    """The exact tractions but for a factor 1 + rest + amount h^order."""
    solution = exact("hertz-paper", 9, points)
    size = float(np.diff(solution.x)[0])
    factor = 1 + rest + amount * size**order
    fields = {"pressure": factor * solution.pressure, "shear": factor * solution.shear}
    result = surface_result(f"run{points}.csv", "", solution.x, fields, {"time": solution.time})
    return Level(f"run{points}.csv", size, "planted", score_surface(result, Mapping(), solution.scene).comparison)


@pytest.mark.parametrize(("order", "amount"), [(2.0, 0.3), (1.0, 0.05), (1.5, 0.2)])
def test_a_planted_order_is_found_and_the_rest_is_left(order, amount):
    known = study([_level(points, order, amount, 2e-3) for points in POINTS])
    for key in ("peak_pressure", "pressure"):
        line = known.line(key)
        assert order - 0.02 < line.found.order < order + 0.02, key
        assert line.found.value == pytest.approx(2e-3, rel=1e-3), key
        assert abs(line.found.value - 2e-3) <= line.found.uncertainty, key
        assert line.mesh == pytest.approx(amount * known.levels[0].size ** order, rel=1e-3), key


def test_the_finest_comes_first_whatever_the_order_of_the_files():
    known = study([_level(points, 2.0, 0.3, 0.0) for points in (105, 27, 53)])
    assert [level.name for level in known.levels] == ["run105.csv", "run53.csv", "run27.csv"]
    assert known.line("peak_pressure").values[0] == min(known.line("peak_pressure").values)


def test_an_error_that_grows_with_refinement_has_no_order():
    solution = [_level(points, -1.0, 1e-4, 0.0) for points in POINTS[:3]]
    line = study(solution).line("peak_pressure")
    assert line.found.kind == "diverging"
    assert line.mesh is None


def test_two_meshes_show_no_order_and_say_so():
    known = study([_level(points, 2.0, 0.3, 0.0) for points in (27, 53)])
    assert known.line("peak_pressure").found.order is None
    assert any("Two meshes show no order" in sentence for sentence in known.sentences)


def test_one_mesh_or_the_same_twice_is_no_study():
    level = _level(27, 2.0, 0.3, 0.0)
    with pytest.raises(InputError, match="takes two meshes at least"):
        study([level])
    with pytest.raises(InputError, match="have the same element size"):
        study([level, level])


def _folder(tmp_path, names):
    for points, name in names.items():
        solution = exact("hertz-paper", 9, points)
        table = rows(solution)
        table["pressure"] *= 1 + 0.3 * float(np.diff(solution.x)[0]) ** 2
        written(table.drop(columns=["P", "Q"]), tmp_path / name)
    return tmp_path


def test_a_folder_is_scored_and_its_sizes_come_from_the_points(tmp_path):
    folder = _folder(tmp_path, {27: "a.csv", 53: "b.csv", 105: "c.csv"})
    (folder / "notes.md").write_text("not a result", encoding="utf-8")
    found = score_folder(folder, Mapping(), exact().scene, Stages(quiet=True))
    assert found.comparison.result.engine == "c.csv"
    assert [level.size for level in found.study.levels] == pytest.approx([0.025, 0.05, 0.1])
    assert found.study.line("peak_pressure").found.order == pytest.approx(2.0, abs=0.02)
    assert any("Left out of the folder: notes.md" in sentence for sentence in found.study.sentences)
    json.dumps(found.study.content())


@pytest.mark.parametrize(
    ("name", "mapping", "size", "how"),
    [
        ("run_h0.5.csv", Mapping(), 0.5, "from the file's name"),
        ("mesh-0.25mm.csv", Mapping(), 0.25, "from the file's name"),
        ("run_h0.5.csv", Mapping(element_sizes={"run_h0.5.csv": 0.125}), 0.125, "from the mapping"),
        ("half.csv", Mapping(), 0.1, "median spacing of the points in contact"),
    ],
)
def test_where_the_element_size_is_from(tmp_path, name, mapping, size, how):
    found = element_size(tmp_path / name, mapping, _level(27, 2.0, 0.3, 0.0).comparison)
    assert found == (pytest.approx(size), how)


def test_one_file_of_each_stem_is_taken_and_an_empty_folder_refused(tmp_path):
    with pytest.raises(InputError, match="no result is in this folder"):
        results_in(tmp_path)
    for name in ("a.frd", "a.dat", "b.csv", "c.md"):
        (tmp_path / name).write_text("x", encoding="utf-8")
    found = results_in(tmp_path)
    assert [path.name for path in found.files] == ["a.frd", "b.csv"]
    assert found.notes == ("Left out of the folder: a.dat, c.md.",)


def test_what_a_collection_names_is_read_through_it(tmp_path):
    """Each instant of a PVD would else be a mesh of its own."""
    entry = '<DataSet timestep="{k}" file="fine_{k}.vtu"/>'
    entries = "".join(entry.format(k=k) for k in range(3))
    head = '<VTKFile type="Collection" version="0.1"><Collection>'
    (tmp_path / "fine.pvd").write_text(f"{head}{entries}</Collection></VTKFile>", encoding="utf-8")
    (tmp_path / "coarse.vtu.series").write_text(json.dumps({"files": [{"name": "c0.vtu", "time": 0.0}]}), encoding="utf-8")
    for name in ("fine_0.vtu", "fine_1.vtu", "fine_2.vtu", "c0.vtu", "alone.vtu"):
        (tmp_path / name).write_text("x", encoding="utf-8")
    found = results_in(tmp_path)
    assert [path.name for path in found.files] == ["alone.vtu", "coarse.vtu.series", "fine.pvd"]
    assert found.notes == ("Read through the collections that name them: 4 files.",)
    (tmp_path / "fine.pvd").write_text("<VTKFile", encoding="utf-8")
    with pytest.raises(InputError, match=r"fine\.pvd: this can't be read as a \.pvd file"):
        results_in(tmp_path)


@pytest.mark.parametrize(
    ("text", "is_result"),
    [
        ("Run of 2026-05-04 on 3 meshes: 0.1, 0.05 and 0.025 mm.\nMesh 2 took 17 s.\n", False),
        ("# x p q\n-1.0 0.0 0.0\n0.0 1.0e2 3D1\n", True),
        ("x;p;q\n-1,0;0,0;0,0\n", True),
    ],
)
def test_a_text_without_a_table_is_no_result(tmp_path, text, is_result):
    (tmp_path / "a.csv").write_text("x", encoding="utf-8")
    (tmp_path / "README.txt").write_text(text, encoding="utf-8")
    found = results_in(tmp_path)
    assert [path.name for path in found.files] == (["README.txt", "a.csv"] if is_result else ["a.csv"])
    assert found.notes == (() if is_result else ("Left out of the folder: README.txt.",))
