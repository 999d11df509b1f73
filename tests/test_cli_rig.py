"""Commands on a scene whose rig prescribes a displacement."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import semi_analytic
from command_line import (
    COARSE,
    HERTZ_SCENE,
    answer_of,
    halfplane,
    json_of,
    refused,
    require_schema,
)
from reports.inputs import input_effects
from reports.page.rig import Motion, RigMotion, loops
from scenes import load_scene

RIG = (
    HERTZ_SCENE
    + """[load]
kind = "polygon"
initial_loading = [[90.0, 0.0]]
cycle = [[90.0, 0.01], [90.0, -0.01]]
tangential_displacement = true
[rig]
datum_length = 50.0
tangential_stiffness = 20000.0
"""
)
SERIES = RIG.replace(
    """kind = "polygon"
initial_loading = [[90.0, 0.0]]
cycle = [[90.0, 0.01], [90.0, -0.01]]
""",
    """kind = "time_series"
file = "rig.csv"
""",
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "rig.toml").write_text(RIG, encoding="utf-8")
    (tmp_path / "series.toml").write_text(SERIES, encoding="utf-8")
    rows = "time,P [N/mm],U [um]\n0,0,0\n1,90,0\n2,90,10\n3,90,-10\n"
    (tmp_path / "rig.csv").write_text(rows, encoding="utf-8")
    return tmp_path


def answer(folder: Path, *words: str) -> tuple[int, dict[str, Any]]:
    return answer_of(halfplane(folder, *words, "--json"), *words)


def test_check_and_run_say_how_far_the_bodies_slide(folder: Path) -> None:
    code, checked = answer(folder, "check", "rig.toml")
    assert code == 0
    slides = [note for note in checked["notes"] if "slide as a whole by" in note]
    assert len(slides) == 1
    ran = json.loads(halfplane(folder, "run", "rig.toml", "--out", "out", "--json", *COARSE).stdout)
    require_schema(ran)
    assert (ran["command"], ran["exit_code"]) == ("exact", 0)
    solved = ran["result"]
    assert solved["dissipation"] == pytest.approx(checked["rig"]["dissipation"], rel=1e-12)
    found = load_scene(folder / "out" / "scene.json").load
    assert np.abs(np.array(found.cycle)[:, 1]).max() == pytest.approx(45.0, rel=1e-12)
    assert json_of(folder / "out" / "semi_analytic.json")["notes"] == solved["notes"]
    way = float(slides[0].split("slide as a whole by ")[1].split()[0])
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert f"The bodies slide as a whole by {way:.6g} mm in the last cycle." in page
    assert page.count("<figure") == 2
    # Finite elements beside theory: in the table, in the loop, in the JSON.
    beside = solved["finite_elements"]
    assert beside["admissible"]
    assert beside["dissipation"] == pytest.approx(solved["dissipation"], rel=5e-3)
    assert f"{beside['dissipation']:.6g}" in page
    assert "contact, finite elements" in page
    slide = page.split("slide by finite elements [mm]</dt><dd>")[1].split("<")[0]
    assert float(slide) == pytest.approx(way, rel=5e-3)
    with (folder / "out" / "figures" / "rig_loop.csv").open(encoding="utf-8") as lines:
        assert {row["engine"] for row in csv.DictReader(lines)} == {
            "half-plane theory",
            "finite elements",
        }
    assert "P and Q follow from the displacements" in page
    assert Path(solved["page"]).name == "report.html"
    # The figures' table: it slides there and back, by the same way, and Q rests meanwhile.
    with (folder / "out" / "figures" / "rig_over_time.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    slip = [float(row["way that the bodies slide [mm]"]) for row in rows]
    for motion, force in (("slides forward", 45.0), ("slides back", -45.0)):
        sliding = [
            number
            for number, row in enumerate(rows)
            if number and row["motion in the step before"].startswith(motion)
        ]
        assert {round(float(rows[number]["Q [N/mm]"]), 9) for number in sliding} == {force}
        distance = sum(abs(slip[number] - slip[number - 1]) for number in sliding)
        assert distance == pytest.approx(way / 2, rel=1e-5)


def test_how_near_a_rig_is_to_sliding_stands_in_terminal_page_and_json(folder: Path) -> None:
    """And that it may slide within the uncertainty of the inputs."""
    near = RIG.replace("0.01]", "0.0032]") + '[uncertainty]\nfriction = "5 %"\n'
    (folder / "near.toml").write_text(near, encoding="utf-8")
    _, solved = answer(folder, "exact", "near.toml", "--out", "alone")
    ratio = solved["largest_sliding_ratio"]
    assert 0.9 < ratio < 1
    assert solved["inputs"]["sliding"]["in_reach"]
    _, checked = answer(folder, "check", "near.toml")
    assert checked["rig"]["largest_sliding_ratio"] == pytest.approx(ratio, rel=1e-6)
    assert f"|Q|/(f P) is at most {ratio:.4g}" in checked["sentence"]
    shown = " ".join(halfplane(folder, "run", "near.toml", "--out", "out", *COARSE).stdout.split())
    assert "largest |Q|/(f P) of the last cycle, 1" in shown
    assert f"{ratio:.4g}" in shown
    assert "Within two standard uncertainties of the inputs |Q| reaches f P" in shown
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert "in the last cycle, but with these inputs the bodies may" in page
    assert 'class="verdict open"' in page
    assert f"1 where all slides</dt><dd>{ratio:.4g}</dd>" in page


def test_a_page_that_fails_leaves_the_answer(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fault(*_arguments: object, **_named: object) -> None:
        raise RuntimeError("no page")

    monkeypatch.setattr("reports.page.rig.write", fault)
    halfplane(folder, "run", "series.toml", "--out", "out")
    assert json_of(folder / "out" / "semi_analytic.json")["dissipation"] > 0
    assert not (folder / "out" / "report.html").exists()


def test_the_legend_of_several_rigs_names_what_their_panels_draw() -> None:
    """The actuator where a rig has a spring, and finite elements where they were solved."""

    def legend(name: str, *, by_elements: bool = False) -> list[str]:
        scene = load_scene(name)
        solution = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",))
        beside = solution if by_elements else None
        return [key.text for key in loops([RigMotion(scene, solution, None, beside)]).keys]

    assert legend("rig-gross-slip") == ["contact"]
    assert legend("rig-compliant") == ["contact", "actuator"]
    assert legend("rig-gross-slip", by_elements=True) == ["contact", "contact, finite elements"]


SLIDING = {
    "normal_load": [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0],
    "tangential_load": [0.0, 0.1, 0.5, 0.5, -0.5, 0.0, 0.0],
    "contact_half_width": [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0],
    "stick_half_width": [1.0, 0.9, np.nan, np.nan, np.nan, np.nan, 1.0],
}


def test_a_motion_is_that_of_a_step_between_two_instants() -> None:
    """What begins or ends to slide within a step does not slide as a whole in it."""
    solution = SimpleNamespace(
        last_cycle=np.arange(7), **{name: np.array(values) for name, values in SLIDING.items()}
    )
    scene = SimpleNamespace(friction=SimpleNamespace(coefficient=0.5))
    motions = RigMotion(scene, solution).motions[1:]  # type: ignore[arg-type]
    assert [Motion(int(motion)).name for motion in motions] == [
        "PARTIAL",
        "PARTIAL",
        "FORWARD",
        "PARTIAL",
        "APART",
        "APART",
    ]


@pytest.mark.parametrize("command", ["export", "advise", "fields"])
def test_commands_that_need_loads_say_so(command: str, folder: Path) -> None:
    assert "P and Q follow from the displacement" in refused(folder, command, "rig.toml")


def test_finite_elements_find_the_loads_of_a_displacement(folder: Path) -> None:
    """Their Q is that of corrected theory to the coarse mesh, their U what the spring leaves."""
    code, solved = answer(folder, "fe", "rig.toml", "--out", "fe", *COARSE)
    assert code == 0
    for words in ("rig: Q is an unknown of each increment", "slide as a whole by"):
        assert any(words in note for note in solved["notes"])
    _, checked = answer(folder, "check", "rig.toml")
    by_theory = checked["rig"]
    assert solved["dissipation"] == pytest.approx(by_theory["dissipation"], rel=5e-3)
    least, largest = load_scene(folder / "fe" / "scene.json").ranges_of_load()[1]
    assert largest == pytest.approx(by_theory["largest_tangential_load"], rel=1e-8)
    assert least == pytest.approx(-largest, rel=1e-8)


PAD = (
    RIG.replace("radius = 1000.0", "radius = 50.0")
    .replace("90.0", "900.0")
    .replace("datum_length = 50.0\n", "")
    + """
[bodies.lower]
kind = "block"
width = 20.0
height = 8.0
[bodies.upper]
kind = "pad"
width = 12.0
height = 12.0
"""
)


def test_of_curved_faces_finite_elements_alone_know_how_far_they_move(folder: Path) -> None:
    (folder / "pad.toml").write_text(PAD, encoding="utf-8")
    code, checked = answer(folder, "check", "pad.toml")
    assert code == 0
    assert "Finite elements alone take this scene" in checked["remarks"][0]
    assert "rig" not in checked


def test_inputs_of_pads_under_a_prescribed_displacement_are_those_of_blocks(folder: Path) -> None:
    """Said beforehand, and with the answer; of cylinders nothing is known, and a sweep is named."""
    stated = '[uncertainty]\nfriction = "5 %"\n'
    block = PAD.replace('kind = "pad"', 'kind = "block"')
    cylinder = PAD.replace(
        'kind = "pad"\nwidth = 12.0\nheight = 12.0', 'kind = "cylinder"\nradius = 50.0'
    )
    for name, text in (("pad", PAD), ("block", block), ("cylinder", cylinder)):
        (folder / f"{name}.toml").write_text(text + stated, encoding="utf-8")
    of_pad = input_effects(load_scene(folder / "pad.toml"))
    of_block = input_effects(load_scene(folder / "block.toml"))
    assert of_pad is not None
    assert of_block is not None
    assert of_pad.values == of_block.values
    assert of_pad.work_uncertainty > 0.01
    assert "pads are taken as blocks" in of_pad.notes[-1]
    assert "pads are taken as blocks" not in " ".join(of_block.notes)
    _, checked = answer(folder, "check", "cylinder.toml")
    of_cylinder = input_effects(load_scene(folder / "cylinder.toml"))
    assert of_cylinder is not None
    for words in ("will not be known", "a cylinder is curved", "`halfplane sweep`"):
        assert words in checked["remarks"][1]
    assert of_cylinder.reason_unknown in checked["remarks"][1]


@pytest.mark.slow
def test_run_of_curved_faces_is_the_answer_of_finite_elements(folder: Path) -> None:
    (folder / "pad.toml").write_text(PAD, encoding="utf-8")
    ran = json.loads(halfplane(folder, "run", "pad.toml", "--out", "out", "--json", *COARSE).stdout)
    require_schema(ran)
    assert (ran["command"], ran["exit_code"]) == ("fe", 0)
    assert ran["result"]["dissipation"] > 0
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert "Nothing slides as a whole in the last cycle" in page
