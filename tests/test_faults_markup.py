"""What comes in can't run, steer or leave its place: markup, formulas, paths, cards, escapes, objects made of bytes."""

from __future__ import annotations

import ast
import json
import os
import stat
from collections import Counter
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest

from fuzzing import condensed_body
from halfplane_fe.elasticity import condense
from halfplane_fe.store import _write
from reports.console import say, show_table
from reports.folder import claim, default_folder, filled
from reports.staging import replace_text
from reports.sweep.store import Store
from reports.third.deck import Deck, DeckSettings, build_deck
from reports.third.dialects import deck_text
from scenes import InputError, load_scene

ROOT = Path(__file__).parents[1]


def test_a_name_can_not_bring_a_card_into_a_deck() -> None:
    evil = dict.fromkeys(("name", "title", "units"), "x\n*INCLUDE, INPUT=/etc/passwd\x85*STEP")
    settings = DeckSettings(element_size=0.25, edge_element_size=0.25, far_radius=10.0, growth=0.9, steps_per_cycle=4, cycles=1)
    deck = build_deck(load_scene("hertz-normal"), settings)
    wrong = replace(deck, scene=deck.scene.vary(**evil))

    def cards(deck: Deck, command: str) -> list[str]:
        lines = deck_text(deck, "calculix", command, {"halfplane": command}).splitlines()
        return [line for line in lines if line.startswith("*") and not line.startswith("**")]

    assert cards(wrong, "a\n*STEP") == cards(deck, "")


def test_the_terminal_is_not_steered(capsys: pytest.CaptureFixture[str]) -> None:
    say("title \x1b]0;owned\x07 \x1b[2J [bold]literal[/bold]")
    show_table("\x1b[2J", ("a",), [("\x1b[31m",)])
    out = capsys.readouterr().out
    assert not [sign for sign in "\x1b\x07" if sign in out]
    assert "[bold]literal[/bold]" in out
    assert "\x1b" not in str(InputError("x.toml: \x1b[2J"))


# ---------------------------------------------------------------------------------------------------------------- paths
@pytest.mark.parametrize("name", ["../../x", "/etc/passwd", "..", ".", "", "a b/c", "a\x00b", "~/x", "CON", "x" * 20])
def test_names_never_lead_out_of_the_folder(name: str) -> None:
    folder = default_folder(name)
    assert folder.parent == Path("out")
    assert folder.name not in {"", ".", ".."}
    assert not [sign for sign in "/\x00" if sign in folder.name]


@pytest.mark.parametrize("listed", [["../victim"], ["{out}/../victim"], ["link/victim"], ["a/../../victim"], 7, [7], [""], None])
def test_a_manifest_never_has_files_removed_outside(listed: object, tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("stays")
    out = tmp_path / "out"
    out.mkdir()
    (out / "link").symlink_to(tmp_path, target_is_directory=True)
    # One that lists itself is taken for ours, so that its other names count; what is no list is somebody else's.
    files = [*listed, "manifest.json"] if isinstance(listed, list) else listed
    (out / "manifest.json").write_text(json.dumps({"written by": "halfplane", "files": files}).replace("{out}", str(out)))
    refusal = nullcontext() if isinstance(listed, list) else pytest.raises(InputError, match=r"manifest\.json is there already")
    with refusal, filled(out) as folder:
        (folder / "a.txt").write_text("new")
    assert (tmp_path / "victim").read_text() == "stays"


def test_nothing_is_written_through_a_link_that_leads_out(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out" / "figures").symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    refusal = pytest.raises(InputError, match="would be written outside, through a link")
    with refusal, filled(tmp_path / "out") as folder:
        (folder / "figures").mkdir()
        (folder / "figures" / "a.csv").write_text("x")
    assert list((tmp_path / "elsewhere").iterdir()) == []
    assert claim(tmp_path / "out")


def test_an_address_in_a_plan_is_no_path(tmp_path: Path) -> None:
    victim = tmp_path / "victim.json"
    victim.write_text("{}")
    store = Store(tmp_path / "sweep")
    store.prepare()
    plan = {"study": {}, "points": [{"number": 0, "address": "../../victim", "coordinates": {}}]}
    (store.folder / "sweep.json").write_text(json.dumps(plan))
    with pytest.raises(InputError, match="no address of a result"):
        store.read_plan()
    assert victim.exists()


# ------------------------------------------------------------------------------------------- sources that run what they read
# Modules that make objects, and so run code, out of bytes.
MODULES = {"pickle", "_pickle", "cPickle", "marshal", "shelve", "dill", "cloudpickle", "joblib", "yaml", "jsonpickle"}
CALLS = {"eval", "exec", "compile", "__import__", "os.system"}
METHODS = {"read_pickle", "to_pickle", "mktemp", "popen"}


def dangers(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or "", *(f"{node.module}.{alias.name}" for alias in node.names)]
        yield from (f"import {name}" for name in names if set(name.split(".")) & MODULES)
        if isinstance(node, ast.Call):
            word = ast.unparse(node.func)
            given = {one.arg: ast.unparse(one.value) for one in node.keywords}
            method = isinstance(node.func, ast.Attribute) and node.func.attr in METHODS
            loads = word in {"np.load", "numpy.load"} and given.get("allow_pickle") != "False"
            if word in CALLS or method or loads or "True" in (given.get("allow_pickle"), given.get("shell")):
                yield f"{word} with {given}"


def test_no_source_file_can_run_what_it_reads() -> None:
    files = [
        path for name in ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports") for path in (ROOT / name).rglob("*.py")
    ]
    assert len(files) > 100
    found = {f"{path}: {danger}" for path in files for danger in dangers(ast.parse(path.read_text(encoding="utf-8")))}
    assert found == set()
    planted = (
        *("import pickle", "from pickle import loads", "import joblib.memory", "from yaml import safe_load", "exec(text)"),
        *("np.load(path)", "np.load(path, allow_pickle=True)", "pd.read_pickle(path)", "subprocess.run(text, shell=True)"),
        *("tempfile.mktemp()", "os.system(text)"),
    )
    assert [line for line in planted if not list(dangers(ast.parse(line)))] == []
    assert not list(dangers(ast.parse("np.load(f, allow_pickle=False); ast.parse(t, mode='eval'); json.loads(t); re.compile(t)")))


# --------------------------------------------------------------------------------------------------------------- rights
@pytest.fixture
def generous() -> Iterator[None]:
    """An umask that gives every right to everybody."""
    before = os.umask(0)
    yield
    os.umask(before)


def rights(path: str | Path) -> int:
    return stat.S_IMODE(os.stat(path).st_mode)


@pytest.mark.usefixtures("generous")
def test_a_folder_that_is_being_filled_is_private_and_the_filled_one_is_not(tmp_path: Path) -> None:
    with filled(tmp_path / "out") as staging:
        (staging / "figures").mkdir()
        (staging / "figures" / "a.csv").write_text("x")
        assert rights(staging) == 0o700
    assert (rights(tmp_path / "out"), rights(tmp_path / "out" / "figures" / "a.csv")) == (0o777, 0o666)


WRITERS = {
    "store of a sweep": lambda folder: Store(folder).write_text(folder / "a.json", "{}"),
    "baseline": lambda folder: replace_text(folder / "a.json", "{}"),
    "store of bodies": lambda folder: _write(folder / "a.npz", condense(*condensed_body(), 4.0), Counter()),
}


@pytest.mark.usefixtures("generous")
@pytest.mark.parametrize("writer", WRITERS)
def test_a_file_that_is_being_written_is_private(writer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Seen at the moment at which it gets its rights and its name."""
    seen = []
    for name in ("replace", "chmod"):

        def call(first: str, *rest: object, real: object = getattr(os, name)) -> None:
            seen.append(rights(first))
            real(first, *rest)

        monkeypatch.setattr(os, name, call)
    WRITERS[writer](tmp_path)
    assert seen[0] == 0o600
    assert len(list(tmp_path.iterdir())) == 1
