"""`halfplane init`: answers from options, questions on a terminal, nothing written where nothing should be."""

import os
import pty
import select
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from reports.answers import SceneAnswers, example
from reports.cli import main
from reports.questions import asked
from scenes import InputError, load_scene
from test_cli_commands import environment, everything, refused


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
        assert set(given) == set(SceneAnswers.__dataclass_fields__)
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
        text = example(answers={"friction": 0.25, "mean_normal_load": 123.456, "phase_degrees": 5.0})
        assert comments(text) == comments(example())
        flat = next(line for line in example(answers={"profile": "flat_rounded"}).splitlines() if line.startswith("flat_half"))
        assert flat.index("#") == text.splitlines()[10].index("#")
        assert [line.find("#") for line in text.splitlines()] == [line.find("#") for line in example().splitlines()]

    def test_a_scene_that_can_not_be_is_refused_and_not_written(self, tmp_path: Path) -> None:
        assert "my.toml: " in refused(tmp_path, "init", "my.toml", "--poisson-ratio", "0.7")
        assert "gross sliding" in refused(tmp_path, "init", "my.toml", "--tangential-amplitude", "600")
        assert "goes with --profile flat_rounded" in refused(tmp_path, "init", "my.toml", "--flat-half-length", "1")
        sentence = refused(tmp_path, "init", "my.toml", "--from", "hertz-paper", "--friction", "0.5")
        assert "--friction: it goes with the commented example, not with --from" in sentence

    def test_a_file_that_exists_stays(self, tmp_path: Path) -> None:
        (tmp_path / "my.toml").write_text("mine", encoding="utf-8")
        (tmp_path / "link.toml").symlink_to(tmp_path / "nowhere")
        for name in ("my.toml", "link.toml"):
            assert "is there already and stays as it is" in refused(tmp_path, "init", name, "--friction", "0.5")

    def test_quiet_says_nothing(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["init", str(tmp_path / "my.toml"), "--quiet"]) == 0
        shown = capsys.readouterr()
        assert (shown.out, shown.err) == ("", "")
        assert (tmp_path / "my.toml").read_text(encoding="utf-8").count("FILE.toml") == 0


def scripted(answers: list[str], prompts: list[str]) -> Callable[[str], str]:
    left = iter(answers)

    def ask(prompt: str) -> str:
        prompts.append(prompt)
        return next(left)

    return ask


class TestQuestions:
    def test_enter_takes_the_example(self) -> None:
        prompts: list[str] = []
        text = asked(lambda _text: None, scripted([""] * 20, prompts), lambda _said: None)
        assert tomllib.loads(text) == tomllib.loads(example())
        assert len(prompts) == 12  # no half-length of a flat that is not there
        assert "[0.6]" in next(prompt for prompt in prompts if "friction" in prompt)

    def test_what_can_not_be_read_is_asked_again(self) -> None:
        prompts: list[str] = []
        said: list[str] = []
        typed = ["", "x", "flat", "-5", "stiff", "nan", "80", "", "", "0.5", "0.25", "block", *[""] * 6]
        text = asked(lambda _text: None, scripted(typed, prompts), said.append)
        found = tomllib.loads(text)
        assert found["profile"] == {"kind": "flat_rounded", "radius": 80.0, "flat_half_length": 0.5}
        assert found["material"]["poisson_ratio"] == 0.25
        assert found["bodies"]["lower"]["kind"] == "block"
        assert [words.split(":")[0] for words in said] == ["x", "-5", "stiff", "nan", "0.5"]

    def test_loads_are_asked_again_until_they_are_admissible(self) -> None:
        said: list[str] = []
        tried: list[float] = []

        def check(text: str) -> None:
            tried.append(tomllib.loads(text)["load"]["tangential_amplitude"])
            if tried[-1] > 100:
                raise InputError("gross sliding")

        typed = [*[""] * 6, *["", "", "", "", "600", ""], *["", "", "", "", "20", ""]]
        text = asked(check, scripted(typed, []), said.append)
        assert tried == [600.0, 20.0]
        assert tomllib.loads(text)["load"]["tangential_amplitude"] == 20.0
        assert said == ["That can't be solved: gross sliding. Once more:"]


CTRL_C, END_OF_INPUT = "\x03", "\x04"


def on_a_terminal(folder: Path, answers: Sequence[tuple[str, str]]) -> tuple[int, str]:
    """`halfplane init my.toml` with a terminal before it, and what it showed there.

    Each answer is typed once its prompt shows: what is typed before a terminal is set up for reading may be taken otherwise.
    Ctrl-C is pressed again where nothing comes of it: Python hears it before or in a read, not in the instant between.
    """
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "reports", "init", "my.toml"]
    with subprocess.Popen(command, cwd=folder, env=environment(), stdin=theirs, stdout=theirs, stderr=theirs) as process:
        os.close(theirs)
        shown, begin, left = "", 0, list(answers)
        while part := read_within(ours, process, seconds=60):
            shown += part
            if left and left[0][0] in shown[begin:] and shown.endswith(": "):
                begin, typed = len(shown), left.pop(0)[1]
                if typed == CTRL_C:
                    press_until_heard(ours, process)
                else:
                    os.write(ours, typed.encode())
        process.wait(timeout=60)
    os.close(ours)
    return process.returncode, shown


def press_until_heard(terminal: int, process: subprocess.Popen[bytes]) -> None:
    for _ in range(4):
        process.send_signal(signal.SIGINT)
        if select.select([terminal], [], [], 10.0)[0]:
            return


def read_within(terminal: int, process: subprocess.Popen[bytes], seconds: float) -> str:
    """What the terminal shows next, "" at its end; a failure where nothing comes in time."""
    ready, _, _ = select.select([terminal], [], [], seconds)
    if not ready:
        process.kill()
        pytest.fail(f"the terminal shows nothing more for {seconds:g} s")
    try:
        return os.read(terminal, 4096).decode()
    except OSError:  # the other end is closed
        return ""


class TestTerminal:
    def test_it_asks_and_writes_an_admissible_scene(self, tmp_path: Path) -> None:
        prompts = [": "] * 12
        typed = ["My pad\n", *["\n"] * 5, "0.45\n", *["\n"] * 5]
        code, shown = on_a_terminal(tmp_path, list(zip(prompts, typed, strict=True)))
        assert code == 0, shown
        assert "Coefficient of friction f [0.6]: " in shown
        scene = load_scene(tmp_path / "my.toml")
        assert (scene.title, scene.friction.coefficient) == ("My pad", 0.45)

    @pytest.mark.parametrize(("key", "code"), [(CTRL_C, 130), (END_OF_INPUT, 2)])
    def test_ctrl_c_and_end_of_input_leave_nothing(self, key: str, code: int, tmp_path: Path) -> None:
        found, shown = on_a_terminal(tmp_path, [(": ", "My pad\n"), ("Profile", key)])
        assert (found, "Traceback" in shown) == (code, False), shown
        assert everything(tmp_path) == set()
