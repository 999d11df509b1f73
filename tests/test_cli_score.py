"""`halfplane score` as a person runs it: in an empty folder, a file beside it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from score_results import exact, rows, written

ROOT = Path(__file__).parents[1]


def _halfplane(folder, *words):
    environment = os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "150", "HALFPLANE_CACHE": "off"}
    command = [sys.executable, "-m", "reports", "score", *words]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_a_result_in_metres_and_pascals_is_scored_with_its_page(tmp_path):
    table = rows(exact("hertz-paper", 13, 53)).drop(columns=["P", "Q"])
    table["x"] /= 1e3
    table["slip"] /= 1e3
    table[["pressure", "shear"]] *= 1e6
    written(table, tmp_path / "mine.csv")
    done = _halfplane(tmp_path, "mine.csv", "--scene", "hertz-paper", "--quiet")
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()[:2]
    assert first.startswith("Taken for granted: x multiplied by 1000")
    assert second.startswith("Taken for granted: pressure and shear multiplied by 1e-06")
    assert "mine.csv agrees with half-plane theory" in done.stdout
    assert done.stdout.splitlines()[-1] == "out/score-mine/report.html"
    page = (tmp_path / "out/score-mine/report.html").read_text(encoding="utf-8")
    assert "Taken for granted of the result" in page
    assert "X multiplied by 1000" in page
    content = json.loads((tmp_path / "out/score-mine/comparison.json").read_text(encoding="utf-8"))
    assert len(content["guesses"]) == 2
    assert content["diagnoses"] == []
    assert content["metrics"]["rigid_shift"]["value"] is None


def test_a_wrong_result_is_outside_and_told_what_it_suffers_from(tmp_path):
    table = rows(exact("hertz-paper", 13, 53)).drop(columns=["P", "Q"])
    table["shear"] *= -1
    written(table, tmp_path / "mine.csv")
    done = _halfplane(tmp_path, "mine.csv", "--scene", "hertz-paper", "--quiet", "--out", "here")
    assert done.returncode == 1, done.stderr
    assert "What it most likely suffers from:" in done.stdout
    assert "What it most likely suffers from" in (tmp_path / "here/report.html").read_text(encoding="utf-8")


def test_one_frame_of_a_path_is_scored_and_drawn(tmp_path):
    solution = exact("hertz-paper", 13, 53)
    table = rows(solution)
    one = table[table["time"] == solution.time[5]][["x", "pressure", "shear"]].rename(
        columns={"pressure": "CPRESS", "shear": "CSHEAR1"}
    )
    written(one, tmp_path / "frame.csv")
    done = _halfplane(tmp_path, "frame.csv", "--scene", "hertz-paper", "--quiet", "--json")
    assert done.returncode == 0, done.stderr
    content = json.loads(done.stdout)
    assert content["metrics"]["pressure"]["accurate"] is True
    assert "not in the result" in content["metrics"]["dissipation"]["note"]
    assert (tmp_path / "out/score-frame/report.html").exists()


def test_a_folder_is_a_mesh_study(tmp_path):
    (tmp_path / "meshes").mkdir()
    for points in (27, 53, 105):
        written(rows(exact("hertz-paper", 9, points)), tmp_path / "meshes" / f"run{points}.csv")
    done = _halfplane(tmp_path, "meshes", "--scene", "hertz-paper", "--quiet")
    assert done.returncode == 0, done.stderr
    assert "Mesh study" in done.stdout
    assert "own mesh study" in (tmp_path / "out/score-meshes/report.html").read_text(encoding="utf-8")
    assert len(json.loads((tmp_path / "out/score-meshes/comparison.json").read_text(encoding="utf-8"))["study"]["levels"]) == 3


def test_the_example_of_a_mapping_is_printed(tmp_path):
    done = _halfplane(tmp_path, "--mapping-example")
    assert done.returncode == 0
    (tmp_path / "mapping.toml").write_text(done.stdout, encoding="utf-8")
    written(rows(exact("hertz-paper", 13, 53)), tmp_path / "mine.csv")
    done = _halfplane(tmp_path, "mine.csv", "--scene", "hertz-paper", "--mapping", "mapping.toml", "--quiet")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ((), "name the result to score"),
        (("mine.csv",), "mine.csv: --scene is missing"),
        (("none.csv", "--scene", "hertz-paper"), "none.csv: there is no such file or folder"),
        (("mine.csv", "--scene", "hertz-papr"), "did you mean hertz-paper"),
        (("mine.csv", "--scene", "cattaneo-mindlin"), "its history is not the scene's"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(tmp_path, words, sentence):
    written(rows(exact("hertz-paper", 13, 53)).drop(columns="time"), tmp_path / "mine.csv")
    done = _halfplane(tmp_path, *words, "--quiet")
    assert done.returncode == 2
    assert sentence in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()
