"""The command line's own words: what is misspelt, the list of commands by use, completion, colours."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from reports.cli import main
from reports.console import say, show_table
from test_cli_commands import halfplane

COMMANDS = {
    "Solve": ["run", "exact", "fe", "fields", "sweep", "export"],
    "Judge": ["score", "diff", "advise", "map", "paper"],
    "Scenes": ["init", "check", "scenes", "schema"],
    "Machine": ["doctor", "completion", "--help", "--version"],
}


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("rnu", "there is no command 'rnu'; did you mean run? `halfplane --help` lists them"),
        ("zzz", "there is no command 'zzz'; `halfplane --help` lists them"),
        (
            "run blocks --elment-size 1",
            "run has no option --elment-size; did you mean --element-size? `halfplane run --help` lists them",
        ),
        ("exact blocks --qiet", "exact has no option --qiet; did you mean --quiet? `halfplane exact --help` lists them"),
        ("--zzz", "there is no option '--zzz'; `halfplane --help` lists them"),
        ("run blocks --zzz=1", "run has no option --zzz; `halfplane run --help` lists them"),
        ("run", "run: SCENE is missing; `halfplane run --help` shows what it takes"),
        ("run blocks more words", "run: unexpected argument 'more words'; `halfplane run --help` shows what it takes"),
        ("sweep statsu out", "sweep: unexpected argument 'out'; did you mean status? `halfplane sweep --help` shows what it takes"),
        ("sweep study.toml out", "sweep: unexpected argument 'out'; `halfplane sweep --help` shows what it takes"),
        ("export blocks", "export: --to is missing; `halfplane export --help` shows what it takes"),
    ],
)
def test_unknown_words_get_one_sentence(arguments: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments.split()) == 2
    shown = capsys.readouterr()
    assert shown.err == f"halfplane: {sentence}\n"
    assert shown.out == ""


def test_an_old_name_of_a_key_gets_one_note(tmp_path: Path) -> None:
    """It was read without a word: Python shows no DeprecationWarning of a library. Each name once, and only on stderr."""
    assert main(["init", str(tmp_path / "old.toml"), "--quiet"]) == 0
    text = (tmp_path / "old.toml").read_text(encoding="utf-8")
    (tmp_path / "old.toml").write_text(text.replace("initial_loading =", "way_in ="), encoding="utf-8")
    done = halfplane(tmp_path, "check", "old.toml", "--json")
    assert done.returncode == 0
    assert done.stderr == "Note: way_in is now called initial_loading; the old name is read until version 0.3.\n"
    assert json.loads(done.stdout)["exit_code"] == 0


def test_commands_are_listed_by_use(tmp_path: Path) -> None:
    """Every command stands in one of the four groups, in this order."""
    found: dict[str, list[str]] = {}
    for line in halfplane(tmp_path, "--help").stdout.split("Examples:")[0].splitlines():
        if line.startswith("╭─ "):
            found[line.split()[1]] = []
        elif line.startswith("│ ") and line[2] != " ":
            found[list(found)[-1]].append(line.split()[1])
    assert found == COMMANDS


class TestCompletion:
    @pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
    def test_script_knows_every_command(self, shell: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["completion", shell]) == 0
        script = capsys.readouterr().out
        for names in COMMANDS.values():
            for name in names:
                assert name.removeprefix("--") in script
        assert "steps-per-cycle" in script

    @pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash here")
    def test_bash_completes_commands_and_options(self, tmp_path: Path) -> None:
        (tmp_path / "words").write_text(halfplane(tmp_path, "completion", "bash").stdout, encoding="utf-8")
        program = 'source ./words; COMP_WORDS=({}); COMP_CWORD={}; _halfplane; printf "%s\\n" "${{COMPREPLY[@]}}"'
        found = {}
        for words in ("halfplane sco", "halfplane fields blocks --anim", "halfplane completion f"):
            command = ["bash", "-c", program.format(words, len(words.split()) - 1)]
            found[words] = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.split()
        assert list(found.values()) == [["score"], ["--animate"], ["fish"]]

    def test_other_shells_are_refused(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["completion", "tcsh"]) == 2
        assert '"bash", "zsh", "fish"' in capsys.readouterr().err


class TestColours:
    ROWS = (("shear", "within"), ("edge", "outside"), ("stick", "undecided"))

    def show(self, capsys: pytest.CaptureFixture[str]) -> str:
        show_table("Verdict", ("metric", "accurate"), self.ROWS)
        say("outside", "bold red")
        return capsys.readouterr().out

    @pytest.fixture(autouse=True)
    def plain(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for name in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE"):
            monkeypatch.delenv(name, raising=False)
        monkeypatch.setenv("TERM", "xterm-256color")

    def test_verdicts_are_coloured_where_the_terminal_has_colours(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.setenv("FORCE_COLOR", "1")
        shown = self.show(capsys)
        assert "\x1b[32mwithin" in shown
        assert "\x1b[1;33mundecided" in shown
        assert shown.count("\x1b[1;31moutside") == 2

    def test_no_color_is_honoured(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        monkeypatch.setenv("FORCE_COLOR", "1")
        monkeypatch.setenv("NO_COLOR", "1")
        shown = self.show(capsys)
        assert "\x1b[32m" not in shown
        assert "31m" not in shown

    def test_a_pipe_gets_plain_text(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert "\x1b" not in self.show(capsys)
        assert os.environ["TERM"] == "xterm-256color"
