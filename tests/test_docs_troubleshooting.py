"""The messages on the troubleshooting page are those that the program prints."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from reports.cli.application import main

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8").replace("\\|", "|")
SCENE = """
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
cycle = [[90.0, 27.0], [90.0, -27.0]]
"""
BLOCK = '[bodies.lower]\nkind = "block"\nwidth = 20.0\nheight = 5.0\n'
RECORD = ('"polygon"\ninitial_loading = [[90.0, 0.0]]\ncycle = [[90.0, 27.0], [90.0, -27.0]]', '"time_series"\nfile = "rec.csv"')
FOOT = ('"hertz"\nradius = 1000.0', '"tabulated"\nfile = "foot.csv"')
# Key of the scene that is spoilt, what it becomes, parts of the message.
SPOILT = [
    (("radius", "radus"), ["unknown key profile.radus = 1000.0; did you mean radius?"]),
    (("cycle =", "wear_rate = 10.0\ncycle ="), ["wear is not modelled"]),
    (("90.0, 27.0", "90.0, 47.0"), ["gross sliding from time ", "|Q| exceeds f P"]),
    (("90.0, -27.0", "-5.0, 0.0"), ["separation from time ", "P is not positive there"]),
    ((SCENE, SCENE + BLOCK.replace("20.0", "1.0")), ["the contact ", "reaches past the end of the narrower face"]),
    ((SCENE, SCENE + BLOCK + 'base = "rollers"\n'), ["nothing holds the block against the tangential load"]),
    (RECORD, ["rec.csv, line 4: P = 'x' is not a finite number"]),
    (FOOT, ["foot.csv, line 4: h = 0.4 falls: the profile must rise"]),
]
# Parts of messages that take a whole run, and the file that prints them.
OF_RUNS = {
    "halfplane_fe/contact.py": ["nodes still change state after ", "iterations at time "],
    "halfplane_fe/solve.py": ["the contact reached the end of the meshed side"],
    "halfplane_fe/resolution.py": ["elements from its middle to its edge where it is smallest", "elements wide at most"],
    "halfplane_fe/store.py": ["the store of condensed bodies (", "condensations read there ", "condensed again, and "],
    "meshes/bodies.py": ["nodes on its contact, and the limit is "],
    "reports/cli/application.py": ["there is not enough memory for this", "ask for a coarser mesh, fewer steps or fewer instants"],
    "reports/cli/solving.py": [
        "pictures can't be drawn here: ",
        "--no-pictures leaves them out",
        "this counts as outside: exit code ",
    ],
    "reports/folder.py": ["is there already and halfplane did not write it"],
}


@pytest.mark.parametrize(("edit", "parts"), SPOILT, ids=[parts[0][:30] for _, parts in SPOILT])
def test_check_prints_what_the_page_quotes(
    edit: tuple[str, str], parts: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rec.csv").write_text("time,P,Q\n0,0,0\n1,90,0\n2,x,3\n", encoding="utf-8")
    (tmp_path / "foot.csv").write_text("x,h\n0,0\n1,0.5\n2,0.4\n", encoding="utf-8")
    (tmp_path / "my.toml").write_text(SCENE.replace(*edit), encoding="utf-8")
    assert main(["check", str(tmp_path / "my.toml")]) == 2
    message = re.sub(r"\s+", " ", capfd.readouterr().err)
    assert not [part for part in parts if part not in message or part not in PAGE]


def test_messages_of_long_runs_are_in_the_code_and_on_the_page() -> None:
    for file, parts in OF_RUNS.items():
        source = (ROOT / file).read_text(encoding="utf-8")
        assert not [part for part in parts if part not in source or part not in PAGE], file


def test_the_remark_on_units_is_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "my.toml").write_text(SCENE.replace("210e3", "210"), encoding="utf-8")
    assert main(["check", str(tmp_path / "my.toml")]) == 0
    remark = "material.young_modulus = 210 MPa is as soft as a weak plastic; steel has 210000 MPa. Is E in GPa?"
    assert remark in re.sub(r"\s+", " ", capfd.readouterr().out)
    assert remark in PAGE
