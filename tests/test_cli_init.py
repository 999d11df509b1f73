"""`halfplane init`: the commented example with values from options, nothing written where nothing should be."""

import tomllib
from dataclasses import fields
from pathlib import Path

import pytest

from reports.cli import main
from reports.cli.scene_files import InitOptions, example
from scenes import load_scene


def comments(text: str) -> list[str]:
    return [line.split("#", 1)[1] for line in text.splitlines() if "#" in line]


class TestOptions:
    def test_what_is_given_stands_in_the_file_and_the_rest_is_the_example(self, tmp_path: Path) -> None:
        file = tmp_path / "my.toml"
        given = {
            "title": 'A "dovetail" \\ root',
            "profile": "flat_rounded",
            "radius": 250.0,
            "flat_half_length": 1.5,
            "young_modulus": 115e3,
            "poisson_ratio": 0.32,
            "friction": 0.4,
            "mean_normal_load": 300.0,
            "normal_amplitude": 12.0,
            "mean_tangential_load": -20.0,
            "tangential_amplitude": 35.0,
            "phase_degrees": 60.0,
        }
        assert set(given) == {one.name for one in fields(InitOptions)} - {"start", "bodies", "quiet"}
        options = [word for name, value in given.items() for word in (f"--{name.replace('_', '-')}", str(value))]
        assert main(["init", str(file), *options, "--bodies"]) == 0
        scene = load_scene(file)
        assert (scene.title, scene.profile.kind, scene.friction.coefficient) == (given["title"], "flat_rounded", 0.4)
        for part in (scene.profile, scene.load, tomllib.loads(file.read_text(encoding="utf-8"))["material"]):
            values = part if isinstance(part, dict) else part.model_dump()
            found = {name: value for name, value in values.items() if name in given}
            assert found == {name: given[name] for name in found}
        assert scene.bodies.upper.kind == "pad"
        assert not {"radius", "flat_half_length"} - set(scene.profile.model_dump())

    def test_what_nobody_said_is_said_nowhere(self) -> None:
        """The words that stand on the page are the user's, not the example's: purpose and source wait as comments."""
        stated = tomllib.loads(example())
        assert not {"purpose", "source"} & set(stated)
        assert stated["title"]

    def test_comments_stay(self) -> None:
        """Every comment of the example, in its order; columns move only where the new number has no room."""
        text = example(given={"friction": 0.25, "mean_normal_load": 123.456, "phase_degrees": 5.0})
        assert comments(text) == comments(example())
        flat = next(line for line in example(given={"profile": "flat_rounded"}).splitlines() if line.startswith("flat_half"))
        assert flat.index("#") == text.splitlines()[10].index("#")
        assert [line.find("#") for line in text.splitlines()] == [line.find("#") for line in example().splitlines()]

    def test_quiet_says_nothing(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["init", str(tmp_path / "my.toml"), "--quiet"]) == 0
        shown = capsys.readouterr()
        assert (shown.out, shown.err) == ("", "")
        assert (tmp_path / "my.toml").read_text(encoding="utf-8").count("FILE.toml") == 0
