"""Words from scenes and results in pages, tables, decks and the terminal: shown as they are, never run."""

from __future__ import annotations

import csv
import io
import json
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

import reports
from reports.charts.table import harmless, table_text
from reports.comparison import Report
from reports.console import say, show_table
from reports.folder import claim, default_folder, filled
from reports.notebook import scene_html, solution_html
from reports.sweep.page import write_page
from reports.sweep.points import expand
from reports.sweep.running import run
from reports.sweep.store import Planned, Store
from reports.sweep.study import study_of
from scenes import InputError, Scene, load_scene
from test_reports_synthetic import cattaneo_mindlin

SCRIPT = "<script>document.title='run'</script>"
EVIL = f"""{SCRIPT}</script><img src=x onerror="document.title='run'"> " onmouseover="x" $\\frac{{ {{{{ 7*7 }}}} &amp; ]]> <!--"""


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
            if name.startswith("on") or address.startswith(("javascript:", "data:text/html")):
                self.dangers.append((tag, name, value))
            if name in {"href", "src", "xlink:href", "action"} and address.startswith(("http", "//")):
                self.dangers.append((tag, name, value))
            if tag == "img" and name == "src" and not str(value).startswith("data:image/"):
                self.dangers.append((tag, name, value))
        if tag in {"iframe", "object", "embed", "base", "form"}:
            self.dangers.append((tag, "", ""))

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def hostile(scene: Scene) -> Scene:
    return scene.vary(**dict.fromkeys(("name", "title", "purpose", "source", "units"), EVIL))


def evil_report() -> Report:
    truth = cattaneo_mindlin()
    record = replace(truth.record, notes=(EVIL,), message=EVIL)
    changed = {"scene": hostile(truth.scene), "record": record, "settings": {EVIL: EVIL}, "versions": {EVIL: EVIL}}
    found = reports.compare(replace(truth, **changed), replace(truth, engine=EVIL, **changed), polygon_reference=truth)
    return Report(replace(found, notes=(EVIL,)), guesses=(EVIL,))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return reports.write(evil_report(), tmp_path_factory.mktemp("evil") / "out", command=EVIL, log=(EVIL,))


@pytest.fixture(scope="module")
def sweep_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweep") / "out"
    axis = {"name": "f", "label": EVIL, "unit": EVIL, "key": "friction.coefficient", "values": [1.0, 1.5]}
    words = {"names": [EVIL, "g"], "keys": ["title", "cycles"], "pairs": [["=1+1", 1], [EVIL, 2]]}
    content = {"scene": "hertz-paper", "title": EVIL, "purpose": EVIL, "engines": ["exact"], "figures": ["exact.dissipation"]}
    study = study_of(content | {"axes": [axis, words]}, "evil")
    store = Store(folder)
    store.prepare()
    points = expand(study)
    store.write_plan(json.loads(study.model_dump_json()), [Planned(p.number, p.address, p.coordinates) for p in points])
    run(study, folder, workers=1)
    evil = {"address": points[0].address, "status": "failed", "values": {}, "figures": {}, "seconds": 1.0, "reason": EVIL}
    store.write(evil)
    return write_page(store)


def test_the_report_shows_hostile_words_and_runs_none(page: Path, tmp_path: Path) -> None:
    plain = Page(reports.write(reports.compare(cattaneo_mindlin(), cattaneo_mindlin()), tmp_path / "out").read_text("utf-8"))
    found = Page(page.read_text(encoding="utf-8"))
    assert found.dangers == plain.dangers == [("form", "", "")]  # that of the slider
    assert found.scripts == plain.scripts
    assert any(SCRIPT in words for words in found.words)
    assert "49" not in found.words


def test_the_page_of_a_sweep_shows_hostile_words_and_runs_none(sweep_page: Path) -> None:
    found = Page(sweep_page.read_text(encoding="utf-8"))
    assert found.dangers == []
    assert found.scripts == 1  # that of every page, and its policy names it
    assert any(SCRIPT in words for words in found.words)


def test_the_searcher_finds_what_runs() -> None:
    """The tester tested."""
    assert Page(EVIL).scripts == 1
    assert Page(EVIL).dangers
    assert Page("<a href='javascript:x()'>").dangers


@pytest.mark.slow
@pytest.mark.parametrize("which", ["page", "sweep_page"])
def test_a_browser_runs_nothing_of_them(which: str, request: pytest.FixtureRequest) -> None:
    browser = shutil.which("chromium")
    if browser is None:
        pytest.skip("needs chromium")
    address = request.getfixturevalue(which).as_uri()
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=3000", "--dump-dom", address]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert "<title>run</title>" not in done.stdout
    assert "&lt;script&gt;" in done.stdout


def test_notebooks_show_hostile_words_and_run_none() -> None:
    solution = evil_report().comparison.result
    for text in (scene_html(solution.scene), solution_html(solution), evil_report()._repr_html_()):
        assert Page(text).scripts == 0
        assert Page(text).dangers == []


def cells(text: str) -> list[str]:
    return [cell for row in csv.reader(io.StringIO(text)) for cell in row]


FORMULAS = ("=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", " =1")


@pytest.mark.parametrize("formula", FORMULAS)
def test_formulas_in_tables_are_text(formula: str) -> None:
    assert harmless(formula).startswith("'")
    written = cells(table_text({formula: [1.0], "words": [formula]}))
    assert not [cell for cell in written if cell.lstrip().startswith(("=", "+", "@"))]


@pytest.mark.parametrize("number", ["-1", "+1e-3", "-inf", "0", "", "1.5"])
def test_numbers_in_tables_stay(number: str) -> None:
    assert harmless(number) == number


def test_no_table_of_a_report_or_a_sweep_has_a_formula(page: Path, tmp_path: Path) -> None:
    axis = {"names": ["words", "g"], "keys": ["title", "cycles"], "pairs": [["=1+1", 1], ["@x", 2]]}
    content = {"scene": "hertz-normal", "engines": ["exact"], "figures": ["exact.dissipation"], "axes": [axis]}
    folder = tmp_path / "out"
    store = Store(folder)
    store.prepare()
    study = study_of(content, "words")
    assert run(study, folder, workers=1).columns
    found = [cell for path in [folder / "index.csv", *page.parent.rglob("*.csv")] for cell in cells(path.read_text("utf-8"))]
    assert len(found) > 1000
    assert [cell for cell in found if harmless(cell) != cell] == []
    assert "'=1+1" in found


@pytest.mark.parametrize("name", ["../../x", "/etc/passwd", "..", ".", "", "a/b", "a\x00b", "~/x", "CON", "x" * 20])
def test_names_never_lead_out_of_the_folder(name: str) -> None:
    folder = default_folder(name)
    assert folder.parent == Path("out")
    assert folder.name not in {"", ".", ".."}
    assert "/" not in folder.name
    assert "\x00" not in str(folder)


@pytest.mark.parametrize("listed", [["../victim"], ["/tmp/victim"], ["link/victim"], ["a/../../victim"], 7, [7], [""], None])
def test_a_manifest_never_has_files_removed_outside(listed: object, tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("stays")
    out = tmp_path / "out"
    out.mkdir()
    (out / "link").symlink_to(tmp_path, target_is_directory=True)
    (out / "manifest.json").write_text(json.dumps({"written by": "halfplane", "files": listed}))
    try:
        with filled(out) as folder:
            (folder / "a.txt").write_text("new")
    except InputError:
        pass
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


def test_a_name_can_not_bring_a_card_into_a_deck() -> None:
    from reports.third.blocks import header

    scene = load_scene("hertz-paper").vary(name="x\n*INCLUDE, INPUT=/etc/passwd", title="a\n*STEP")

    class Body:
        nodes = ()

    class Deck:
        lower = upper = Body
        time = (0.0, 1.0)

        class settings:
            edge_element_size, far_radius = 0.01, 10.0

        class scales:
            half_width, load = 1.0, 1.0

    deck = Deck()
    deck.scene = scene
    lines = "\n".join(header(deck, (), "", {"halfplane": "1"})).splitlines()
    assert [line for line in lines if line.startswith("*") and not line.startswith("**")] == ["*HEADING"]


def test_the_terminal_is_not_steered(capsys: pytest.CaptureFixture[str]) -> None:
    say("title \x1b]0;owned\x07 \x1b[2J [bold]literal[/bold]")
    show_table("\x1b[2J", ("a",), [("\x1b[31m",)])
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert "\x07" not in out
    assert "[bold]literal[/bold]" in out
    assert "\x1b" not in str(InputError("x.toml: \x1b[2J"))
