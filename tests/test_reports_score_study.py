"""A folder of results: orders of planted errors are found, on both sides, and what no mesh removes is told apart from them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from reports.console import Stages
from reports.scoring.against import score_surface
from reports.scoring.mapping import Mapping
from reports.scoring.study import Level, element_size, results_in, score_folder, study
from reports.scoring.surface import surface_result
from scenes import InputError
from score_results import exact, rows, written

POINTS = (27, 53, 105, 209)


def level(points: int, order: float = 2.0, amount: float = 0.3, rest: float = 0.0, worst: int | None = None) -> Level:
    """The exact tractions but for a factor 1 + rest + amount h^order, twice that at the `worst` instant."""
    solution = exact("hertz-paper", 9, points)
    size = float(np.diff(solution.x)[0])
    factor = 1 + rest + amount * size**order * np.where(np.arange(9) == worst, 2.0, 1.0)[:, None]
    fields = {"pressure": factor * solution.pressure, "shear": factor * solution.shear}
    result = surface_result(f"run{points}.csv", "", solution.x, fields, {"time": solution.time})
    return Level(f"run{points}.csv", size, "planted", score_surface(result, Mapping(), solution.scene).comparison)


@pytest.mark.parametrize(("order", "amount"), [(2.0, 0.3), (1.0, 0.05), (1.5, 0.2)])
def test_a_planted_order_is_found_and_the_rest_is_left(order: float, amount: float) -> None:
    known = study([level(points, order, amount, 2e-3) for points in POINTS])
    for key in ("peak_pressure", "pressure"):
        line = known.line(key)
        assert order - 0.02 < line.found.order < order + 0.02, key
        assert line.found.value == pytest.approx(2e-3, rel=1e-3), key
        assert abs(line.found.value - 2e-3) <= line.found.uncertainty, key
        assert line.mesh == pytest.approx(amount * known.levels[0].size ** order, rel=1e-3), key


def test_the_finest_comes_first_errors_that_grow_have_no_order_and_nor_do_two_meshes() -> None:
    known = study([level(points) for points in (105, 27, 53)])
    assert [one.name for one in known.levels] == ["run105.csv", "run53.csv", "run27.csv"]
    assert known.line("peak_pressure").values[0] == min(known.line("peak_pressure").values)
    grows = study([level(points, -1.0, 1e-4) for points in POINTS[:3]]).line("peak_pressure")
    assert (grows.found.kind, grows.mesh) == ("diverging", None)
    one, other = study([level(53, worst=2), level(27, worst=6)]).line("peak_pressure").values  # both where the finest is worst
    assert other / one == pytest.approx(4 / 2)
    two = study([level(points) for points in (27, 53)])
    assert two.line("peak_pressure").found.order is None
    assert any("Two meshes show no order" in sentence for sentence in two.sentences)
    for levels, words in (([level(27)], "takes two meshes at least"), ([level(27)] * 2, "have the same element size")):
        with pytest.raises(InputError, match=words):
            study(levels)


def test_a_folder_is_scored_and_its_sizes_come_from_the_points(tmp_path: Path) -> None:
    for points, name in {27: "a.csv", 53: "b.csv", 105: "c.csv"}.items():
        solution = exact("hertz-paper", 9, points)
        table = rows(solution).drop(columns=["P", "Q"])
        table["pressure"] *= 1 + 0.3 * float(np.diff(solution.x)[0]) ** 2
        written(table, tmp_path / name)
    (tmp_path / "notes.md").write_text("not a result", encoding="utf-8")
    found = score_folder(tmp_path, Mapping(), exact().scene, Stages(quiet=True))
    assert found.comparison.result.engine == "c.csv"
    assert [one.size for one in found.study.levels] == pytest.approx([0.025, 0.05, 0.1])
    assert found.study.line("peak_pressure").found.order == pytest.approx(2.0, abs=0.02)
    assert any("Left out of the folder: notes.md" in sentence for sentence in found.study.sentences)
    json.dumps(found.study.content())


@pytest.mark.parametrize(
    ("name", "sizes", "size", "how"),
    [
        ("run_h0.5.csv", {}, 0.5, "from the file's name"),
        ("mesh-0.25mm.csv", {}, 0.25, "from the file's name"),
        ("run_h0.5.csv", {"run_h0.5.csv": 0.125}, 0.125, "from the mapping"),
        ("half.csv", {}, 0.1, "median spacing of the points in contact"),
    ],
)
def test_where_the_element_size_is_from(tmp_path: Path, name: str, sizes: dict[str, float], size: float, how: str) -> None:
    assert element_size(tmp_path / name, Mapping(element_sizes=sizes), level(27).comparison) == (pytest.approx(size), how)


ENTRIES = "".join(f'<DataSet timestep="{k}" file="fine_{k}.vtu"/>' for k in range(3))
COLLECTIONS = {
    "fine.pvd": f'<VTKFile type="Collection" version="0.1"><Collection>{ENTRIES}</Collection></VTKFile>',
    "coarse.vtu.series": json.dumps({"files": [{"name": "c0.vtu", "time": 0.0}]}),
} | dict.fromkeys(("fine_0.vtu", "fine_1.vtu", "fine_2.vtu", "c0.vtu", "alone.vtu"), "x")
FOLDERS = {
    "one file of each stem": (
        dict.fromkeys(("a.frd", "a.dat", "b.csv", "c.md"), "x"),
        "a.frd b.csv",
        "Left out of the folder: a.dat, c.md.",
    ),
    "collections": (COLLECTIONS, "alone.vtu coarse.vtu.series fine.pvd", "Read through the collections that name them: 4 files."),
    "words": (
        {"a.csv": "x", "README.txt": "3 meshes: 0.1, 0.05 and 0.025 mm.\nMesh 2 took 17 s.\n"},
        "a.csv",
        "Left out of the folder: README.txt.",
    ),
    "a table": ({"a.csv": "x", "b.txt": "# x p q\n-1.0 0.0 0.0\n0.0 1.0e2 3D1\n"}, "a.csv b.txt", ""),
    "with decimal commas": ({"a.csv": "x", "b.txt": "x;p;q\n-1,0;0,0;0,0\n"}, "a.csv b.txt", ""),
}


@pytest.mark.parametrize("case", FOLDERS)
def test_which_files_of_a_folder_are_results(tmp_path: Path, case: str) -> None:
    """Each instant of a PVD would else be a mesh of its own; a text without a table is none."""
    with pytest.raises(InputError, match="no result is in this folder"):
        results_in(tmp_path)
    files, taken, note = FOLDERS[case]
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    found, notes = results_in(tmp_path)
    assert [path.name for path in found] == taken.split()
    assert notes == ((note,) if note else ())
    if case == "collections":
        (tmp_path / "fine.pvd").write_text("<VTKFile", encoding="utf-8")
        with pytest.raises(InputError, match=r"fine\.pvd: this can't be read as a \.pvd file"):
            results_in(tmp_path)


def test_what_can_not_be_read_in_a_folder_is_listed_and_the_rest_is_scored(tmp_path: Path) -> None:
    scene, stages = exact().scene, Stages(quiet=True)
    written(rows(exact()), tmp_path / "run_h0.02.csv")
    (tmp_path / "spoilt_h0.1.csv").write_text("x,pressure,shear\n0,1,oops\n", encoding="utf-8")
    (tmp_path / "junk_h0.2.vtu").write_text("no XML", encoding="utf-8")
    one = score_folder(tmp_path, Mapping(), scene, stages)
    told = [note for note in one.comparison.notes if note.startswith("Not scored: ")]
    assert one.study is None
    assert one.comparison.result.engine == "run_h0.02.csv"
    assert told[1] == "Not scored: spoilt_h0.1.csv, line 2: shear = 'oops' is not a finite number of at most 1e+100."
    assert told[0].startswith("Not scored: junk_h0.2.vtu: ")
    written(rows(exact(points=53)), tmp_path / "run_h0.04.csv")
    both = score_folder(tmp_path, Mapping(), scene, stages)
    assert both.study is not None
    assert [level.name for level in both.study.levels] == ["run_h0.02.csv", "run_h0.04.csv"]
    assert [note for note in both.study.notes if note.startswith("Not scored: ")] == told
    for good in tmp_path.glob("run*"):
        good.unlink()
    with pytest.raises(InputError, match=r"junk_h0\.2\.vtu: .*\(1 other files of the folder can't be scored either\)"):
        score_folder(tmp_path, Mapping(), scene, stages)
