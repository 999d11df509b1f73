"""`--json`: one document of one schema on stdout and nothing else, the same values as the words, and the exit code of the words."""

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from reports.cli import main
from reports.cli.answers import FORMAT, answer_schema
from reports.cli.application import app
from reports.cli.process import OUTSIDE, WITHIN
from reports.paper.page import PaperReport
from reports.paper.tables import Misprint, Statement, Verdict
from scenes import ConvergenceError, scene_text
from test_cli_commands import COARSE

STUDY = """
title = "Friction"
scene = "hertz-paper"
engines = ["exact"]
figures = ["exact.dissipation"]
[[axes]]
name = "f"
key = "friction.coefficient"
values = [1.0, 1.2]
"""


@pytest.fixture
def said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """Runs a command in an empty folder: its exit code and what the document that is its whole stdout holds as `result`."""
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> tuple[int, dict[str, Any]]:
        code = main([*words, "--json"])
        found = json.loads(capsys.readouterr().out)
        jsonschema.validate(found, answer_schema())
        assert (found["format"], found["exit_code"]) == (FORMAT, code)
        assert " ".join(words).startswith(found["command"])
        return code, found["result"]

    return run


class TestAdvice:
    def test_every_departure_and_their_sum(self, said: Any) -> None:
        code, found = said("advise", "blocks")
        assert code == WITHIN
        assert found["within_limit"] is found["passed"] is True
        (blocks,) = found["departures"]
        assert blocks["errors"] == found["sum_of_known"]
        assert blocks["errors"]["dissipation"]["error"] == pytest.approx(-0.0277, abs=0.005)  # the published run
        assert set(blocks["errors"]) == {"dissipation", "p0", "contact_half_width"}
        assert found["sentence"].startswith("Yes: dissipation")

    def test_beyond_the_limit_is_outside(self, said: Any) -> None:
        code, found = said("advise", "blocks", "--limit", "0.02")
        assert code == OUTSIDE
        assert found["within_limit"] is found["passed"] is False

    def test_an_uncertainty_across_the_limit_is_undecided(self, said: Any) -> None:
        """At a limit of the error itself; it was a plain no."""
        error = said("advise", "blocks")[1]["sum_of_known"]["dissipation"]["error"]
        code, found = said("advise", "blocks", "--limit", f"{abs(error):.4g}")
        assert (code, found["verdict"], found["within_limit"]) == (OUTSIDE, "undecided", False)
        assert found["sentence"].startswith("Not sure: ")
        assert "the uncertainty reaches across the limit" in found["sentence"]

    def test_what_no_map_knows_is_null_and_outside(self, said: Any) -> None:
        code, found = said("advise", "pad-on-block")
        assert code == OUTSIDE
        assert (found["within_limit"] is None) is any(one["errors"] is None for one in found["departures"])

    def test_half_planes_have_no_departure(self, said: Any) -> None:
        _, found = said("advise", "hertz-paper")
        assert found["departures"] == []
        assert found["sum_of_known"] is None


def test_extrapolated_advice_has_no_uncertainty_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A flat pad of a/R = 0.54: the map ends at 0.4, and its own uncertainty there was printed as if it were known beyond."""
    monkeypatch.setenv("COLUMNS", "400")
    text = scene_text("flat-pad-on-block").split("[[expected]]")[0].split("[tolerances]")[0]
    (tmp_path / "pad.toml").write_text(text, encoding="utf-8")
    assert main(["advise", str(tmp_path / "pad.toml")]) == OUTSIDE
    out = capsys.readouterr().out
    (arcs,) = (line for line in out.splitlines() if "true arcs" in line)
    assert "extrapolated" in arcs
    assert "about −" in arcs
    assert "±" not in arcs
    assert "map `curvature`, pad" in out  # the name that `halfplane map` takes


def test_a_limit_in_per_cent_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["advise", "blocks", "--limit", "5"]) == 2
    assert "such as 0.05 for 5 %" in capsys.readouterr().err


def test_fields_tell_instants_and_files(said: Any) -> None:
    code, found = said("fields", "hertz-normal", "--no-pictures", "--quiet", *COARSE)
    assert code == WITHIN
    assert Path(found["file"]).exists()
    assert all((Path("out/hertz-normal") / name).exists() for name in found["files"])
    assert all(one[name]["value"] > 0 for one in found["instants"] for name in ("largest_nodal_von_mises", "largest_nodal_tension"))
    assert found["instants"]
    assert "not peaks" in found["largest nodal stresses"]


def test_export_tells_what_the_deck_holds(said: Any) -> None:
    code, found = said("export", "hertz-normal", "--to", "calculix", "--quiet")
    assert code == WITHIN
    deck = Path(found["file"]).read_text(encoding="utf-8")
    assert found["nodes"] > found["elements"] / 2 > 100
    assert f"\n{found['nodes']}, " in deck


def test_a_sweep_tells_its_points_and_where_its_files_are(said: Any, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    code, found = said("sweep", "study.toml", "--workers", "1", "--quiet")
    assert code == WITHIN
    assert found["points"]["done"] == found["points"]["total"] == 2
    assert Path(found["file"]).read_text(encoding="utf-8").count("\n") == 3
    assert said("sweep", "status", "out/study")[1]["points"] == found["points"]
    page = said("sweep", "report", "out/study")[1]
    assert page["points"] == found["points"]
    assert Path(page["page"]).exists()


def test_a_sweep_takes_a_worker_at_least(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """None meant all cores without a word."""
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    assert main(["sweep", str(tmp_path / "study.toml"), "--workers", "0", "--out", str(tmp_path / "out")]) == 2
    assert "--workers 0: at least 1" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_map_tells_its_page(said: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[Path] = []
    monkeypatch.setattr("reports.maps.pages.write", lambda folder, there: written.append(folder))
    code, found = said("map", "unlike", "--pages", "--out", "maps")
    assert code == WITHIN
    assert found["studies"] == {}  # pages alone run none
    assert [Path(found["page"]).parent] == written


def test_the_paper_tells_both_tables(said: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    statement = Statement("key", "where", "words", "computed", Verdict.REFINED, {"a": 1.0})
    misprint = Misprint("key", "where", "printed", "right", "proof", None, {})
    report = PaperReport((statement,), (misprint,), Path("out/report.html"))
    monkeypatch.setattr("reports.paper.page.write", lambda *_: report)
    _, found = said("paper", "--quiet")
    assert found["verdicts"] == {"confirmed": 0, "refined": 1, "contradicted": 0}
    assert found["statements"][0]["verdict"] == "refined"
    assert found["misprints"][0]["proven"] is None


def test_every_command_with_json_is_in_the_schema(said: Any) -> None:
    """And what no other test of this file asks of the schema."""
    kept = str(Path(__file__).parent / "fixtures" / "format1")
    assert said("run", "cattaneo-mindlin", "--quiet", *COARSE)[1]["metrics"]["shear"]["verdict"] == "outside"
    assert said("fe", "cattaneo-mindlin", "--quiet", *COARSE)[1]["engine"] == "halfplane_fe"
    assert said("exact", "cattaneo-mindlin", "--quiet")[1]["admissible"] is True
    assert said("check", "cattaneo-mindlin")[1]["passed"] is True
    assert said("doctor")[1]["checks"]["Python"]["good"] is True
    assert said("scenes", "flight")[1]["scenes"][0]["files"] == ["flight.csv", "flight.py"]
    assert said("diff", f"{kept}/result.nc", f"{kept}/baseline.json")[1]["same"] is True
    assert said("score", f"{kept}/result.nc", "--scene", "cattaneo-mindlin", "--quiet")[1]["metrics"]["shear"]["value"] > 0
    commands = {one["if"]["properties"]["command"]["const"] for one in answer_schema()["allOf"]}
    silent = {"init", "schema", "completion"}
    assert commands == {name for name in app if name[0] != "-"} - silent | {"sweep status", "sweep report"}


def test_the_manual_lists_every_key_that_the_schema_requires() -> None:
    schema = answer_schema()
    text = (Path(__file__).parents[1] / "docs" / "json.md").read_text(encoding="utf-8")
    listed = {
        command: set(re.findall(r"`([^`]+)`", keys)) for command, keys in re.findall(r"(?m)^\| `([^`]+)` \| (`.*`) \|$", text)
    }
    for one in schema["allOf"]:
        result = one["then"]["properties"]["result"]
        table = result["anyOf"][1] if "anyOf" in result else result
        table = schema["$defs"][table["$ref"].removeprefix("#/$defs/")] if "$ref" in table else table
        assert listed[one["if"]["properties"]["command"]["const"]] == set(table["required"])


def test_the_schema_refuses_another_envelope_and_a_lost_key() -> None:
    answer = {"format": FORMAT, "command": "doctor", "exit_code": 0, "scene": None, "result": {"passed": True, "checks": {}}}
    jsonschema.validate(answer, answer_schema())
    for wrong in ({**answer, "format": "halfplane verdict 1"}, {**answer, "result": {"passed": True}}, {**answer, "more": 1}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, answer_schema())


def test_a_reference_that_does_not_converge_is_an_answer_too(said: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object, **__: object) -> None:
        raise ConvergenceError("step 3 does not converge")

    monkeypatch.setattr("halfplane_fe.solve", fails)
    kept = str(Path(__file__).parent / "fixtures" / "format1" / "result.nc")
    code, found = said("score", kept, "--scene", "cattaneo-mindlin", "--against", "fe", "--quiet")
    assert (code, found["passed"], found["file"]) == (3, False, None)
    assert found["error"] == "the reference is not converged: step 3 does not converge"


def test_schema_prints_both(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "--answers"]) == 0
    assert json.loads(capsys.readouterr().out) == answer_schema()
