"""`halfplane score` as a person runs it: in an empty folder, a file beside it."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from reports.cli import main
from score_results import exact, rows, written

ROOT = Path(__file__).parents[1]
ABAQUS = ROOT / "docs" / "examples" / "score" / "abaqus"
TABLE = rows(exact("hertz-paper", 13, 53)).drop(columns=["P", "Q"])
Score = Callable[..., tuple[int, str, str]]


@pytest.fixture
def score(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Score:
    """Runs `score` in the folder: exit code, stdout, stderr. Bad input is one sentence, and the folder stays as it was."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "150")

    def run(*words: object, scene: str = "hertz-paper") -> tuple[int, str, str]:
        before = sorted(Path().iterdir())
        code = main(["score", *map(str, words), *(["--scene", scene] if scene else []), "--quiet"])
        shown = capsys.readouterr()
        if code == 2:
            assert sorted(Path().iterdir()) == before
            assert shown.out == ""
            assert len(shown.err.splitlines()) == 1
        return code, shown.out, shown.err

    return run


def content(folder: str) -> Any:
    return json.loads((Path("out") / folder / "comparison.json").read_text(encoding="utf-8"))


def test_a_result_in_metres_and_pascals_is_scored_with_its_page(tmp_path: Path) -> None:
    """By a process of its own."""
    factors = {"x": 1e-3, "slip": 1e-3, "pressure": 1e6, "shear": 1e6}
    written(TABLE.assign(**{name: factor * TABLE[name] for name, factor in factors.items()}), tmp_path / "mine.csv")
    environment = os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "150", "HALFPLANE_CACHE": "off"}
    command = [sys.executable, "-m", "reports", "score", "mine.csv", "--scene", "hertz-paper", "--quiet"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()[:2]
    assert first.startswith("Taken for granted: x multiplied by 1000")
    assert second.startswith("Taken for granted: pressure and shear multiplied by 1e-06")
    assert "mine.csv agrees with half-plane theory" in done.stdout
    assert done.stdout.splitlines()[-1] == "out/score-mine/report.html"
    page = (tmp_path / "out/score-mine/report.html").read_text(encoding="utf-8")
    assert "Taken for granted of the result" in page
    assert "X multiplied by 1000" in page
    found = json.loads((tmp_path / "out/score-mine/comparison.json").read_text(encoding="utf-8"))
    assert (len(found["guesses"]), found["diagnoses"]) == (2, [])
    assert found["metrics"]["tangential_displacement"]["value"] is None


def test_a_wrong_result_is_outside_with_its_likely_causes(score: Score) -> None:
    written(TABLE.assign(shear=-TABLE["shear"]), Path("mine.csv"))
    code, out, _ = score("mine.csv", "--out", "here")
    assert code == 1
    assert "Likely causes:" in out
    assert "Likely causes of the difference" in Path("here/report.html").read_text(encoding="utf-8")


def test_a_tolerance_judges_before_that_of_the_scene(score: Score) -> None:
    """Shear 0.05 % too large: within the engines' own tolerance, outside one of 1e-5; a key that is none is refused."""
    written(TABLE.assign(shear=1.0005 * TABLE["shear"]), Path("mine.csv"))
    assert score("mine.csv")[0] == 0
    code, out, _ = score("mine.csv", "--tolerance", "shear=0.001%")
    assert (code, "tolerance in shear traction, L2" in " ".join(out.split())) == (1, True)
    code, _, err = score("mine.csv", "--tolerance", "sheer=5%")
    assert (code, "unknown metric 'sheer'" in err) == (2, True)


def test_one_frame_of_a_path_is_scored_and_drawn_with_the_example_of_a_mapping(score: Score) -> None:
    frame = TABLE[TABLE["time"] == TABLE["time"][53 * 5]][["x", "pressure", "shear"]]
    written(frame.rename(columns={"pressure": "CPRESS", "shear": "CSHEAR1"}), Path("frame.csv"))
    code, out, _ = score("--mapping-example", scene="")
    Path("mapping.toml").write_text(out, encoding="utf-8")
    code, out, err = score("frame.csv", "--json", "--mapping", "mapping.toml")
    assert code == 0, err
    found = json.loads(out)["result"]
    assert found["metrics"]["pressure"]["accurate"] is True
    assert "not in the result" in found["metrics"]["dissipation"]["note"]
    assert Path("out/score-frame/report.html").exists()


def test_a_folder_is_a_mesh_study(score: Score) -> None:
    Path("meshes").mkdir()
    for points in (27, 53, 105):
        written(rows(exact("hertz-paper", 9, points)), Path("meshes") / f"run{points}.csv")
    code, out, err = score("meshes")
    assert code == 0, err
    assert "Mesh study" in out
    assert "own mesh study" in Path("out/score-meshes/report.html").read_text(encoding="utf-8")
    assert len(content("score-meshes")["study"]["levels"]) == 3


@pytest.mark.parametrize(
    ("words", "scene", "sentence"),
    [
        ((), "", "name the result to score"),
        (("mine.csv",), "", "mine.csv: --scene is missing"),
        (("none.csv",), "hertz-paper", "none.csv: there is no such file or folder"),
        (("mine.csv",), "hertz-papr", "did you mean hertz-paper"),
        (("mine.csv",), "cattaneo-mindlin", "its history is not the scene's"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(score: Score, words: tuple[str, ...], scene: str, sentence: str) -> None:
    written(rows(exact("hertz-paper", 13, 53)).drop(columns="time"), Path("mine.csv"))
    code, _, err = score(*words, scene=scene)
    assert (code, sentence in err) == (2, True), err


@pytest.mark.parametrize(
    ("file", "mapping", "sentence"),
    [
        # Ten times the offset that is right; it was a division by zero that ended like a result outside tolerance.
        (
            "path.rpt",
            "14.978",
            "from x = -14.978 to -11.9824, the contact from -1 to 1; state its x at the middle of the contact by x_offset",
        ),
        ("own-times.csv", "factors.load = 1e-300", "own-times.csv: instant 1 is at time"),
        ("own-times.csv", "thickness = 1e308", "own-times.csv: instant 1 is at time"),
        (
            "mine.csv",
            'signs.pressure = "compression negative"',
            "no point is in compression: state the other sign, or leave it out",
        ),
    ],
)
def test_what_a_mapping_states_of_a_whole_file_is_refused_where_nothing_is_left_to_score(
    score: Score, file: str, mapping: str, sentence: str
) -> None:
    table = rows(exact("cattaneo-mindlin", 3, 21))
    written(table, Path("mine.csv"))
    written(table.assign(time=table["time"] + 1e3), Path("own-times.csv"))  # times of another clock: the loads tell the instants
    Path("path.rpt").write_bytes((ABAQUS / "path.rpt").read_bytes())
    stated = (ABAQUS / "mapping.toml").read_text(encoding="utf-8").replace("1.4978", mapping) if file == "path.rpt" else mapping
    Path("mapping.toml").write_text(stated, encoding="utf-8")
    code, _, err = score(file, "--mapping", "mapping.toml", scene="cattaneo-mindlin")
    assert (code, sentence in err) == (2, True), err


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_no_number_of_the_mapping_brings_it_down(score: Score, seed: int) -> None:
    """Offsets, factors, thickness, times, at their ends and beyond: scored or refused, and never an internal error."""
    chance = random.Random(seed)
    numbers = (0, -0.0, 0.5, 1, 1.2, 2.5, -1, 14.978, 1e300, -1e300, 5e-324, 1e-9, 1e-3, 1e6, 1e308, "nan", "inf")
    times = (0, 1, 1.5, 2, 2.5, 3, 13, 1e3, -1)
    written(rows(exact("cattaneo-mindlin", 3, 15)), Path("mine.csv"))
    for _ in range(5):
        keys = ["thickness", "x_offset", "y_offset", *(f"factors.{key}" for key in ("length", "stress", "load", "time"))]
        lines = [f"{key} = {chance.choice(numbers)}" for key in chance.sample(keys, chance.randrange(1, 4))]
        if chance.random() < 0.2:
            lines.append(f"times = {[chance.choice(times) for _ in range(3)]}")
        Path("mapping.toml").write_text("\n".join(lines), encoding="utf-8")
        code, _, err = score("mine.csv", "--mapping", "mapping.toml", scene="cattaneo-mindlin")
        assert code in (0, 1, 2), (lines, err)
