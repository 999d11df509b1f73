"""What comes in can't run, steer or leave its place: markup, formulas, paths, cards, escapes, objects made of bytes."""

from __future__ import annotations

import ast
import csv
import io
import json
import os
import shutil
import stat
import subprocess
from collections import Counter
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

import reports
from fuzzing import condensed_body
from halfplane_fe.elasticity import condense
from halfplane_fe.store import _write
from reports.charts.table import harmless, table_text
from reports.comparison import Report
from reports.console import say, show_table
from reports.folder import claim, default_folder, filled
from reports.page.notebook import scene_html, solution_html
from reports.staging import replace_text
from reports.sweep.page import write_page
from reports.sweep.running import run
from reports.sweep.store import Planned, Store
from reports.sweep.study import expand, study_of
from reports.third.deck import Deck, DeckSettings, build_deck
from reports.third.dialects import deck_text
from scenes import InputError, load_scene
from test_reports_synthetic import cattaneo_mindlin

ROOT = Path(__file__).parents[1]
SCRIPT = "<script>document.title='run'</script>"
EVIL = f"""{SCRIPT}</script><img src=x onerror="document.title='run'"> " onmouseover="x" $\\frac{{ {{{{ 7*7 }}}} &amp; ]]> <!--"""


# ---------------------------------------------------------------------------------------------------------------- pages
class Page(HTMLParser):
    """Tags with what could run in them: scripts, frames, handlers, addresses that are code or lie elsewhere."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.scripts, self.dangers, self.words = 0, [], []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.scripts += tag == "script"
        for name, value in attrs:
            address = str(value).strip().lower()
            code = name.startswith("on") or address.startswith(("javascript:", "data:text/html"))
            elsewhere = name in {"href", "src", "xlink:href", "action"} and address.startswith(("http", "//"))
            if code or elsewhere or (tag == "img" and name == "src" and not address.startswith("data:image/")):
                self.dangers.append((tag, name, value))
        if tag in {"iframe", "object", "embed", "base", "form"}:
            self.dangers.append((tag, "", ""))

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def evil_report() -> Report:
    truth = cattaneo_mindlin(steps_per_leg=10, points=41)
    scene = truth.scene.vary(**dict.fromkeys(("name", "title", "purpose", "source", "units"), EVIL))
    record = replace(truth.record, notes=(EVIL,), message=EVIL)
    changed = {"scene": scene, "record": record, "settings": {EVIL: EVIL}, "versions": {EVIL: EVIL}}
    found = reports.compare(replace(truth, **changed), replace(truth, engine=EVIL, **changed), polygon_reference=truth)
    return Report(replace(found, notes=(EVIL,)), guesses=(EVIL,))


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A report and a sweep in which every word from outside is an attack."""
    home = tmp_path_factory.mktemp("evil")
    axis = {"name": "f", "label": EVIL, "unit": EVIL, "key": "friction.coefficient", "values": [1.0, 1.5]}
    words = {"names": [EVIL, "g"], "keys": ["title", "cycles"], "pairs": [["=1+1", 1], [EVIL, 2], ["@x", 3]]}
    content = {"scene": "hertz-paper", "title": EVIL, "purpose": EVIL, "engines": ["exact"], "figures": ["exact.dissipation"]}
    study = study_of(content | {"axes": [axis, words]}, "evil")
    store, points = Store(home / "sweep"), expand(study)
    store.prepare()
    store.write_plan(json.loads(study.model_dump_json()), [Planned(p.number, p.address, p.coordinates) for p in points])
    run(study, store.folder, workers=1)
    store.write({"address": points[0].address, "status": "failed", "values": {}, "figures": {}, "seconds": 1.0, "reason": EVIL})
    report = reports.write(evil_report(), home / "report", command=EVIL, log=(EVIL,))
    return {"report": report, "sweep": write_page(store)}


def test_pages_show_hostile_words_and_run_none(pages: dict[str, Path], tmp_path: Path) -> None:
    truth = cattaneo_mindlin(steps_per_leg=10, points=41)
    plain = Page(reports.write(reports.compare(truth, truth), tmp_path / "out").read_text("utf-8"))
    report, sweep = (Page(path.read_text(encoding="utf-8")) for path in pages.values())
    assert report.dangers == plain.dangers == [("form", "", "")]  # that of the slider
    assert report.scripts == plain.scripts
    assert (sweep.dangers, sweep.scripts) == ([], 1)  # that of every page, and its policy names it
    for page in (report, sweep):
        assert any(SCRIPT in words for words in page.words)
    assert "49" not in report.words
    solution = evil_report().comparison.result
    for text in (scene_html(solution.scene), solution_html(solution), evil_report()._repr_html_()):
        assert (Page(text).scripts, Page(text).dangers) == (0, [])


def test_the_searcher_finds_what_runs() -> None:
    """The tester tested."""
    assert Page(EVIL).scripts == 1
    assert Page(EVIL).dangers
    assert Page("<a href='javascript:x()'>").dangers


@pytest.mark.slow
@pytest.mark.parametrize("which", ["report", "sweep"])
def test_a_browser_runs_nothing_of_them(which: str, pages: dict[str, Path]) -> None:
    browser = shutil.which("chromium")
    if browser is None:
        pytest.skip("needs chromium")
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=3000", "--dump-dom"]
    done = subprocess.run([*command, pages[which].as_uri()], capture_output=True, text=True, timeout=120, check=True)
    assert "<title>run</title>" not in done.stdout
    assert "&lt;script&gt;" in done.stdout


# -------------------------------------------------------------------------------------------- tables, decks, the terminal
def cells(text: str) -> list[str]:
    return [cell for row in csv.reader(io.StringIO(text)) for cell in row]


@pytest.mark.parametrize("formula", ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", " =1"])
def test_formulas_in_tables_are_text(formula: str) -> None:
    assert harmless(formula).startswith("'")
    written = cells(table_text({formula: [1.0], "words": [formula]}))
    assert not [cell for cell in written if cell.lstrip().startswith(("=", "+", "@"))]


def test_numbers_in_tables_stay_and_no_table_has_a_formula(pages: dict[str, Path]) -> None:
    for number in ("-1", "+1e-3", "-inf", "0", "", "1.5"):
        assert harmless(number) == number
    found = [cell for page in pages.values() for path in page.parent.rglob("*.csv") for cell in cells(path.read_text("utf-8"))]
    assert len(found) > 1000
    assert [cell for cell in found if harmless(cell) != cell] == []
    assert {"'=1+1", "'@x"} <= set(found)


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
