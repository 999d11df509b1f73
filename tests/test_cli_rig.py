"""Commands on a scene whose rig prescribes a displacement."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import COARSE, halfplane, json_of, refused
from reports.page.notebook import scene_html
from scenes import load_scene
from test_cli_commands import answer_of

RIG = """
[material]
young_modulus = 210e3
poisson_ratio = 0.3
[profile]
kind = "hertz"
radius = 1000.0
[friction]
coefficient = 0.5
[load]
kind = "polygon"
initial_loading = [[90.0, 0.0]]
cycle = [[90.0, 0.01], [90.0, -0.01]]
tangential_displacement = true
[rig]
datum_length = 50.0
tangential_stiffness = 20000.0
"""
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


def test_check_and_exact_say_how_far_the_bodies_slide(folder: Path) -> None:
    code, checked = answer(folder, "check", "rig.toml")
    assert code == 0
    slides = [note for note in checked["notes"] if "slide as a whole by" in note]
    assert len(slides) == 1
    code, solved = answer(folder, "exact", "rig.toml", "--out", "out")
    assert code == 0
    assert solved["dissipation"] == pytest.approx(checked["rig"]["dissipation"], rel=1e-12)
    found = load_scene(folder / "out" / "scene.json").load
    assert np.abs(np.array(found.cycle)[:, 1]).max() == pytest.approx(45.0, rel=1e-12)
    assert json_of(folder / "out" / "semi_analytic.json")["notes"] == solved["notes"]


def test_a_series_has_a_column_of_displacements_in_its_unit(folder: Path) -> None:
    load = load_scene(folder / "series.toml").load
    assert load.rows.values[:, 2].tolist() == pytest.approx([0.0, 0.0, 0.01, -0.01])
    code, checked = answer(folder, "check", "series.toml")
    assert code == 0
    assert "gross sliding: in the path" in " ".join(checked["notes"]).lower()


@pytest.mark.parametrize("command", ["export", "advise", "fields"])
def test_commands_that_need_loads_say_so(command: str, folder: Path) -> None:
    assert "P and Q follow from the displacement" in refused(folder, command, "rig.toml")


def test_finite_elements_refuse_what_slides_as_a_whole(folder: Path) -> None:
    assert (
        "from time 1.35184 on the bodies slide as a whole"
        in halfplane(folder, "fe", "rig.toml", "--quiet").stderr
    )


def test_finite_elements_find_the_loads_of_a_displacement(folder: Path) -> None:
    """Their Q is that of corrected theory to the coarse mesh, their U what the spring leaves."""
    text = RIG.replace("0.01]", "0.003]")
    (folder / "partial.toml").write_text(text, encoding="utf-8")
    code, solved = answer(folder, "fe", "partial.toml", "--out", "fe", *COARSE)
    assert code == 0
    assert any("rig: Q follows from the displacement" in note for note in solved["notes"])
    code, theory = answer(folder, "exact", "partial.toml", "--out", "exact")
    assert solved["dissipation"] == pytest.approx(theory["dissipation"], rel=0.1)
    by_elements = load_scene(folder / "fe" / "scene.json").ranges_of_load()[1]
    by_theory = load_scene(folder / "exact" / "scene.json").ranges_of_load()[1]
    assert by_elements == pytest.approx(by_theory, rel=5e-3)


def test_a_notebook_shows_what_the_rig_prescribes(folder: Path) -> None:
    shown = scene_html(load_scene(folder / "rig.toml"))
    assert "U of the actuator" in shown
    assert "-0.01 to 0.01" in shown
