"""CalculiX itself on the decks: it opens them without an edit, converges, and says what theory says within what was measured."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from deck_parser import common_part
from reports import cli
from reports.console import Stages
from reports.third.abaqus import abaqus_deck
from reports.third.deck import build_deck
from reports.third.opinion import ThirdOpinion, ask_calculix
from reports.third.running import find_calculix, run_calculix
from reports.third.settings import DeckSettings
from scenes import load_scene

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("ccx") is None, reason="ccx is not on PATH: make peers installs it"),
]
LIMIT = 900.0


def asked(name: str, **known: float) -> ThirdOpinion:
    opinion = ask_calculix(load_scene(name), DeckSettings(**known), LIMIT, Stages(quiet=True))  # type: ignore[arg-type]
    assert not opinion.failure
    return opinion


# Measured with CalculiX 2.20 beside each figure; the limit is half as much again.
@pytest.mark.parametrize(
    ("name", "limits"),
    [
        ("hertz-normal", {"peak_pressure": 0.0018, "pressure": 0.08}),  # 0.0012, 0.052
        ("cattaneo-mindlin", {"dissipation": 0.03, "peak_pressure": 0.006, "pressure": 0.026, "shear": 0.075}),
    ],
)
def test_tractions_and_work_of_calculix_are_those_of_theory(name: str, limits: dict[str, float]) -> None:
    comparison = asked(name, cycles=1).comparison
    assert comparison is not None
    for key, limit in limits.items():
        value = comparison.metric(key).value
        assert value is not None, key
        assert abs(value) < limit, (key, value)
    result = comparison.result
    assert np.allclose(result.normal_load[1:], comparison.scene.load.path().at(result.time[1:])[0], rtol=2e-3)


def test_calculix_runs_the_part_of_the_abaqus_deck_that_both_share(tmp_path: Path) -> None:
    deck = build_deck(load_scene("hertz-normal"), DeckSettings(edge_element_size=1 / 20, steps_per_cycle=16))
    text = common_part(abaqus_deck(deck), deck.stick_slope)
    (tmp_path / "deck.inp").write_text(text, encoding="utf-8")
    done = run_calculix(find_calculix(), tmp_path, "deck", float(deck.deck_time[-1]), LIMIT)
    assert done.increments >= len(deck.time) - 1
    log = (tmp_path / "deck.log").read_text(encoding="utf-8", errors="replace")
    assert "parameter not recognized" not in log
    assert "*ERROR" not in log


def test_run_with_a_third_opinion_leaves_three_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = cli.main(["run", "hertz-normal", "--third", "calculix", "--out", str(tmp_path / "out"), "--quiet"])
    assert code in (0, 1)
    said = capsys.readouterr().out
    assert "A third opinion" in said
    assert "penalty" in said
    stored = json.loads((tmp_path / "out" / "third.json").read_text(encoding="utf-8"))
    assert stored["failure"] is None
    assert stored["code"].startswith("CalculiX")
    assert abs(stored["metrics"]["peak_pressure"]["third"]) < 0.0018
    assert "A third opinion" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert (tmp_path / "out" / "third.nc").exists()


def test_a_time_limit_is_told_and_the_rest_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["run", "hertz-normal", "--third", "calculix", "--third-limit", "1", "--out", str(tmp_path / "out"), "--quiet"]
    assert cli.main(words) == 3
    assert "time limit of 1 s" in capsys.readouterr().err.replace("\n", " ")
    assert "time limit" in json.loads((tmp_path / "out" / "third.json").read_text(encoding="utf-8"))["failure"]
    assert not (tmp_path / "out" / "third.nc").exists()
