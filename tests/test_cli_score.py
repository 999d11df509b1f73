"""`halfplane score` as a person runs it: in an empty folder, a file beside it."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

import halfplane_fe
from problems import COARSE, FEW_STEPS
from reports.cli import main
from reports.scoring.against import score
from reports.scoring.mapping import Mapping
from scenes import InputError, load_scene
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
    assert content["metrics"]["tangential_displacement"]["value"] is None


def test_a_wrong_result_is_outside_and_told_what_it_suffers_from(tmp_path):
    table = rows(exact("hertz-paper", 13, 53)).drop(columns=["P", "Q"])
    table["shear"] *= -1
    written(table, tmp_path / "mine.csv")
    done = _halfplane(tmp_path, "mine.csv", "--scene", "hertz-paper", "--quiet", "--out", "here")
    assert done.returncode == 1, done.stderr
    assert "Likely causes:" in done.stdout
    assert "Likely causes of the difference" in (tmp_path / "here/report.html").read_text(encoding="utf-8")


def test_a_tolerance_judges_before_that_of_the_scene(tmp_path):
    """Shear 0.05 % too large: within the engines' own tolerance, outside one of 1e-5; a key that is none is refused."""
    table = rows(exact("hertz-paper", 13, 53))
    table["shear"] *= 1.0005
    written(table, tmp_path / "mine.csv")
    asked = ("mine.csv", "--scene", "hertz-paper", "--quiet", "--out", "here")
    assert _halfplane(tmp_path, *asked).returncode == 0
    strict = _halfplane(tmp_path, *asked, "--tolerance", "shear=0.001%")
    assert strict.returncode == 1, strict.stderr
    assert "tolerance in shear traction, L2" in " ".join(strict.stdout.split())
    refused = _halfplane(tmp_path, *asked, "--tolerance", "sheer=5%")
    assert (refused.returncode, "unknown metric 'sheer'" in refused.stderr) == (2, True)


def test_one_frame_of_a_path_is_scored_and_drawn(tmp_path):
    solution = exact("hertz-paper", 13, 53)
    table = rows(solution)
    one = table[table["time"] == solution.time[5]][["x", "pressure", "shear"]].rename(
        columns={"pressure": "CPRESS", "shear": "CSHEAR1"}
    )
    written(one, tmp_path / "frame.csv")
    done = _halfplane(tmp_path, "frame.csv", "--scene", "hertz-paper", "--quiet", "--json")
    assert done.returncode == 0, done.stderr
    content = json.loads(done.stdout)["result"]
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


class TestHeader:
    """What the mapping states of a whole file: refused where it puts the points beside the contact, or leaves no pressure."""

    TABLE = ROOT / "docs" / "examples" / "score" / "abaqus"

    @staticmethod
    def said(capsys, file: Path, mapping: str) -> tuple[int, str]:
        """Exit code and stderr of `score` with this mapping; the folder must stay as it was."""
        Path("mapping.toml").write_text(mapping, encoding="utf-8")
        before = sorted(Path().iterdir())
        code = main(["score", str(file), "--scene", "cattaneo-mindlin", "--mapping", "mapping.toml", "--quiet"])
        shown = capsys.readouterr()
        if code == 2:
            assert sorted(Path().iterdir()) == before
            assert shown.out == ""
            assert len(shown.err.splitlines()) == 1
        return code, shown.err

    @pytest.fixture(autouse=True)
    def here(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)

    def test_a_file_beside_the_contact_is_refused_with_both_ranges(self, capsys):
        """Ten times the offset that is right; it was a division by zero that ended like a result outside tolerance."""
        mapping = (self.TABLE / "mapping.toml").read_text(encoding="utf-8").replace("1.4978", "14.978")
        code, words = self.said(capsys, self.TABLE / "path.rpt", mapping)
        assert code == 2
        assert (
            "from x = -14.978 to -11.9824, the contact from -1 to 1; state its x at the middle of the contact by x_offset" in words
        )

    @pytest.mark.parametrize("against", ["exact", "fe"])
    def test_against_either_engine(self, against, monkeypatch):
        """Of plain arrays too; the finite elements have points of their own."""
        coarse = halfplane_fe.solve(load_scene("cattaneo-mindlin"), COARSE, FEW_STEPS)
        monkeypatch.setattr("halfplane_fe.solve", lambda _scene: coarse)
        found = exact("cattaneo-mindlin", 5, 53)
        x, mapping = found.x + 3.0, Mapping(x_offset=1e-9)  # stated, so that no middle is guessed
        with pytest.raises(InputError, match=r"none of its points lies in the contact: they go from x = 1\.7 to 4\.3"):
            score(x, found.pressure, found.shear, scene=found.scene, time=found.time, against=against, mapping=mapping)

    def test_pressure_at_a_time_without_contact_is_refused(self):
        found, sure = exact("cattaneo-mindlin", 5, 53), Mapping.model_validate({"factors": {"stress": 1.0}})
        with pytest.raises(InputError, match=r"it has pressure at times 0 to 0, where the scene has no contact: state the scene's"):
            score(found.x, 1e-4 * found.pressure[:1], found.shear[:1], scene=found.scene, time=[0.0], mapping=sure)

    @pytest.mark.parametrize("line", ["factors.load = 1e-300", "thickness = 1e308", "factors.load = 1e-3"])
    def test_loads_that_tell_no_instant_are_refused(self, line, capsys, tmp_path):
        table = rows(exact("cattaneo-mindlin", 3, 21))
        table["time"] += 1e3  # times of another clock: the loads tell the instants
        code, words = self.said(capsys, written(table, tmp_path / "mine.csv"), line)
        assert code == 2
        assert "mine.csv: instant 1 is at time" in words

    def test_a_sign_that_leaves_no_compression_is_refused(self, capsys, tmp_path):
        table = written(rows(exact("cattaneo-mindlin", 2, 21)), tmp_path / "mine.csv")
        code, words = self.said(capsys, table, 'signs.pressure = "compression negative"')
        assert code == 2
        assert "no point is in compression: state the other sign, or leave it out" in words

    @pytest.mark.slow
    @pytest.mark.parametrize("seed", range(6))
    def test_no_number_of_the_header_brings_it_down(self, seed, capsys, tmp_path):
        """Offsets, factors, thickness, times, at their ends and beyond: scored or refused, and never an internal error."""
        chance = random.Random(seed)
        numbers = (0, -0.0, 0.5, 1, 1.2, 2.5, -1, 14.978, 1e300, -1e300, 5e-324, 1e-9, 1e-3, 1e6, 1e308, "nan", "inf")
        times = (0, 1, 1.5, 2, 2.5, 3, 13, 1e3, -1)
        table = written(rows(exact("cattaneo-mindlin", 3, 15)), tmp_path / "mine.csv")
        for _ in range(5):
            keys = ["thickness", "x_offset", "y_offset", *(f"factors.{key}" for key in ("length", "stress", "load", "time"))]
            lines = [f"{key} = {chance.choice(numbers)}" for key in chance.sample(keys, chance.randrange(1, 4))]
            if chance.random() < 0.2:
                lines.append(f"times = {[chance.choice(times) for _ in range(3)]}")
            code, words = self.said(capsys, table, "\n".join(lines))
            assert code in (0, 1, 2), (lines, words)
