"""A report: strict JSON, a page that needs no network and runs no word from outside; notebook,
charts.
"""

import csv
import io
import json
import sys
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from jinja2 import UndefinedError
from PIL import Image

import semi_analytic
from reports import Report, compare, figure, write
from reports.charts import templating
from reports.charts.plate import (
    Arrow,
    Axis,
    Band,
    Bitmap,
    Block,
    Cell,
    Curve,
    Dot,
    Group,
    Key,
    Note,
    Panel,
    Plate,
    Rule,
    Segments,
    _png,
    figure_with_texts,
    panel_stacks_of,
)
from reports.charts.templating import marked, style_of, table_text, without_formula
from reports.comparison import Comparison
from reports.comparison.words import summary_rows
from reports.folder import MANIFEST
from reports.page.cycle_view import CycleView
from reports.page.history_figures import hysteresis
from reports.page.writing import _data_of_slider, code_commit, draw
from reports.studies.sweep import running
from reports.studies.sweep.page import write_page
from reports.studies.sweep.store import PlannedPoint, Store
from reports.studies.sweep.study import points_of_study, study_of
from scenes import InputError, Scene, load_scene, scene_names
from test_reports_sweep import Bench
from test_reports_synthetic import EVIL, SCRIPT, cattaneo_mindlin, evil, with_fields

TRUTH = cattaneo_mindlin(steps_per_leg=12, points=61)
FIGURES = {
    *(
        "bodies",
        "cycle",
        "slip_history",
        "tractions",
        "load_path",
        "hysteresis",
        "half_widths",
        "state_map",
        "dissipation_density",
    ),
    "errors",
}


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    """A result 1 % high in pressure, with an engine's name and a note that a page must escape."""
    solution = with_fields(TRUTH, pressure=1.01 * TRUTH.pressure, engine="somebody's <b>code</b>")
    return compare(TRUTH, solution, polygon_reference=TRUTH)


@pytest.fixture(scope="module")
def folder(comparison: Comparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report") / "deep" / "out"
    page = write(
        comparison, out, command="halfplane run 'my scene.toml'", seconds={"finite elements": 1.5}
    )
    assert page == out / "report.html"
    return out


def test_rings_on_the_loops_start_where_the_slider_has_them() -> None:
    """Each on its own curve: the Q of the result is 1 % above that of the reference."""
    solution = with_fields(TRUTH, tangential_load=1.01 * TRUTH.tangential_load)
    view = CycleView(compare(TRUTH, solution, polygon_reference=TRUTH))
    slider = _data_of_slider(view)
    loops = hysteresis(view)
    assert loops is not None
    rings = [
        mark
        for panel in loops.panels
        for mark in panel.marks
        if isinstance(mark, Dot) and mark.css.startswith("follow")
    ]
    assert len(rings) == 4
    for ring in rings:
        for name, value in (("series_x", ring.x), ("series_y", ring.y)):
            place = slider["series"][ring.data[name]][slider["start"]]
            assert place == pytest.approx(value, rel=1e-6), ring


def read_json(path: Path) -> dict:
    """Strict: the words NaN and Infinity, which Python's reader takes, are refused."""

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_everything_is_there(folder: Path) -> None:
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    tables = {f"figures/{name}.csv" for name in FIGURES}
    assert tables <= files
    assert files - tables == {
        "report.html",
        "comparison.json",
        "reference.nc",
        "result.nc",
        "scene.json",
        MANIFEST,
    }
    assert set(read_json(folder / MANIFEST)["files"]) == files


def test_without_git_the_commit_is_unknown(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """In a folder that is no checkout, and on a machine where git answers nothing or is missing."""
    module = tmp_path / "halfplane" / "reports" / "page" / "writing.py"
    monkeypatch.setattr("reports.page.writing.__file__", str(module))
    assert code_commit() == "unknown: installed without its history"
    module.parents[2].mkdir()
    (module.parents[2] / ".git").touch()
    assert code_commit() == "unknown: git does not answer"
    monkeypatch.setenv("PATH", str(tmp_path))
    assert code_commit() == "unknown: git does not answer"


def test_tables_hold_what_the_figures_draw(folder: Path, comparison: Comparison) -> None:
    for drawing in draw(Report(comparison)):
        with (folder / "figures" / f"{drawing.name}.csv").open(
            encoding="utf-8", newline=""
        ) as stream:
            rows = list(csv.DictReader(stream))
        assert list(rows[0]) == list(drawing.table)
        for name, column in drawing.table.items():
            if not isinstance(column[0], str):
                numbers = [float(row[name]) if row[name] else np.nan for row in rows]
                assert np.array_equal(numbers, np.asarray(column, dtype=float), equal_nan=True), (
                    name
                )
        if drawing.name == "state_map":
            heading = "state_reference (0 open, 1 stick, 2 forward slip, 3 reverse slip)"
            stored = np.array([int(row[heading]) for row in rows]).reshape(len(TRUTH.time), -1)
            assert np.array_equal(stored, TRUTH.state[:, np.abs(TRUTH.x) <= 1.12])


def test_with_bulk_stress_and_tilt_page_file_and_console_name_them_and_both_works(
    tmp_path: Path, folder: Path
) -> None:
    """P = 3, Q = +-1.8, eps = +-0.3 (E* = R = f = 1): W in closed form; where U alone is drawn,
    nobody may take it for that.
    """
    work = 0.9368781396315213
    load = {"kind": "polygon", "initial_loading": [(3.0, 0.0), (3.0, 1.8)], "cycle": [(3.0, -1.8)]}
    load |= {"bulk_stress_lower": (0.0, 0.6, -0.6), "tilt": 0.0}
    soft = {"young_modulus": 2.0, "poisson_ratio": 0.0}
    profile = {"kind": "hertz", "radius": 1.0}
    scene = Scene.model_validate(
        {"material": soft, "profile": profile, "friction": 1.0, "load": load}
    )
    exact = semi_analytic.solve(
        scene, x=np.linspace(-2.4, 2.4, 81), time=np.linspace(4.0, 6.0, 161)
    )
    comparison = compare(exact, exact)
    write(comparison, tmp_path / "out")
    content, plain = (read_json(path / "comparison.json") for path in (tmp_path / "out", folder))
    assert (
        "The lower body is under a bulk stress from −0.6 to 0.6 MPa along x. The upper body is"
        " tilted by 0 rad." in content["question"]
    )
    assert " under bulk stress and tilt" in content["headline"]
    assert "bulk" not in plain["question"] + plain["headline"]
    answer = content["reference"]
    assert answer["loop_work"] == pytest.approx(work, rel=1e-10)
    assert (answer["permanent_stick_left"], answer["permanent_stick_right"]) == pytest.approx(
        (-0.93607744, 1.53607744), abs=1e-7
    )
    added = {"bulk_work", "permanent_stick_left", "permanent_stick_right"}
    assert added <= answer.keys()
    assert not added & plain["reference"].keys()
    # Both works by the rows of the figure's table, and their sum.
    rows = list(
        csv.DictReader(
            (tmp_path / "out" / "figures" / "hysteresis.csv")
            .read_text(encoding="utf-8")
            .splitlines()
        )
    )
    force = np.array([float(row["Q"]) for row in rows])
    shift = np.array([float(row["U_reference"]) for row in rows])
    loop = float(np.trapezoid(force, shift))
    assert loop + answer["bulk_work"] == pytest.approx(work, rel=1e-3)
    assert abs(loop / work - 1) > 0.1
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for words in (
        "With bulk stress that is not the dissipation",
        "of it −∮",
        "ε = σ/E′",
        "σ, lower body",
    ):
        assert words in page, words
        assert words not in (folder / "report.html").read_text(encoding="utf-8"), words
    summary = dict(summary_rows(exact))
    assert float(
        next(summary[name] for name in summary if name.startswith("closed integral of (Q dU - m_q"))
    ) == pytest.approx(work)
    assert any(name.startswith("of it by bulk stress") for name in summary)
    assert not any("m_q" in name for name, _ in summary_rows(TRUTH))


class Page(HTMLParser):
    """Tags with attributes, words, and what could run: scripts, frames, handlers, addresses that
    are code or lie elsewhere.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.scripts = 0
        self.dangers = []
        self.words = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        self.scripts += tag == "script"
        for name, value in attrs:
            address = str(value).strip().lower()
            code = name.startswith("on") or address.startswith(("javascript:", "data:text/html"))
            elsewhere = name in {"href", "src", "xlink:href", "action"} and address.startswith(
                ("http", "//")
            )
            if (
                code
                or elsewhere
                or (tag == "img" and name == "src" and not address.startswith("data:image/"))
            ):
                self.dangers.append((tag, name, value))
        if tag in {"iframe", "object", "embed", "base", "form"}:
            self.dangers.append((tag, "", ""))

    def handle_data(self, text: str) -> None:
        self.words.append(text)


@pytest.fixture(scope="module")
def page(folder: Path) -> Page:
    return Page((folder / "report.html").read_text(encoding="utf-8"))


def test_page_needs_no_network(page: Page, folder: Path) -> None:
    """Figures are inside; every other address is a file of the folder or a place on the page."""
    places = {attributes["id"] for _, attributes in page.found if "id" in attributes}
    names = ("src", "href", "action", "data", "poster", "srcset")
    for address in (
        value for _, attributes in page.found for name in names if (value := attributes.get(name))
    ):
        if address.startswith("#"):
            assert address[1:] in places
        elif not address.startswith("data:image/png;base64,"):
            assert (folder / address).is_file(), address
    assert "link" not in {tag for tag, _ in page.found}
    assert "@import" not in (folder / "report.html").read_text(encoding="utf-8")
    assert (folder / "report.html").stat().st_size < 8e6


def test_page_has_every_figure_with_words_for_it(page: Page) -> None:
    figures = [attributes for tag, attributes in page.found if tag == "figure"]
    assert len(figures) == len(FIGURES)
    panels = [
        attributes
        for tag, attributes in page.found
        if tag == "svg" and attributes.get("role") == "img"
    ]
    assert len(panels) > len(FIGURES)
    assert all(attributes["aria-label"] for attributes in (*figures, *panels))
    identities = [attributes["id"] for _, attributes in page.found if "id" in attributes]
    assert len(identities) == len(set(identities))


# All that a table and the sentences about it are made of.
TABLE = {"div", "p", "b", "table", "tr", "th", "td"}


class TestNotebook:
    """Well-formed HTML in which every word from outside is escaped."""

    def test_every_scene_of_the_library(self) -> None:
        for scene in map(load_scene, scene_names()):
            table = ET.fromstring(scene._repr_html_())
            assert scene.title in "".join(table.itertext())
            assert len(table.findall(".//tr")) == 10 + scene.load.has_bulk_or_tilt
            assert {element.tag for element in table.iter()} <= TABLE

    def test_words_from_outside_are_escaped(self) -> None:
        hostile = evil()
        nothing = with_fields(
            hostile.result, tangential_displacement=np.full(len(TRUTH.time), np.nan)
        )
        for shown_value in (hostile.scene, hostile.result, nothing, hostile, Report(hostile)):
            words = shown_value._repr_html_()
            assert EVIL in "".join(ET.fromstring(words).itertext())
            assert (Page(words).scripts, Page(words).dangers) == (0, [])


# -------------------------------------------------------- words from outside on pages and in tables
@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A report and a sweep in which every word from outside is an attack."""
    home = tmp_path_factory.mktemp("evil")
    axis = {
        "name": "f",
        "label": EVIL,
        "unit": EVIL,
        "key": "friction.coefficient",
        "values": [1.0, 1.5],
    }
    words = {
        "names": [EVIL, "g"],
        "keys": ["title", "cycles"],
        "pairs": [["=1+1", 1], [EVIL, 2], ["@x", 3]],
    }
    content = {
        "scene": "hertz-paper",
        "title": EVIL,
        "purpose": EVIL,
        "engines": ["exact"],
        "figures": ["exact.dissipation"],
    }
    study = study_of(content | {"axes": [axis, words]}, "evil")
    store = Store(home / "sweep")
    points = points_of_study(study)
    store.prepare()
    store.write_plan(
        json.loads(study.model_dump_json()),
        [PlannedPoint(p.number, p.address, p.coordinates) for p in points],
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "worker_pool", lambda **_: Bench())
        running.run(study, store.folder)
    store.write(
        {
            "address": points[0].address,
            "status": "failed",
            "values": {},
            "figures": {},
            "seconds": 1.0,
            "reason": EVIL,
        }
    )
    report = write(Report(evil(), guesses=(EVIL,)), home / "report", command=EVIL, log=(EVIL,))
    return {"report": report, "sweep": write_page(store)}


def test_pages_show_hostile_words_and_run_none(pages: dict[str, Path], page: Page) -> None:
    report, sweep = (Page(path.read_text(encoding="utf-8")) for path in pages.values())
    assert report.dangers == page.dangers == [("form", "", "")]  # that of the slider
    assert report.scripts == page.scripts == 2  # the data and the page's own
    assert (sweep.dangers, sweep.scripts) == ([], 1)  # that of every page, and its policy names it
    for each in (report, sweep):
        assert any(SCRIPT in words for words in each.words)
    assert "49" not in report.words


def test_the_searcher_finds_what_runs() -> None:
    """The tester tested."""
    assert Page(EVIL).scripts == 1
    assert Page(EVIL).dangers
    assert Page("<a href='javascript:x()'>").dangers


def cells(text: str) -> list[str]:
    return [cell for row in csv.reader(io.StringIO(text)) for cell in row]


@pytest.mark.parametrize(
    "formula", ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", " =1"]
)
def test_formulas_in_tables_are_text(formula: str) -> None:
    assert without_formula(formula).startswith("'")
    written = cells(table_text({formula: [1.0], "words": [formula]}))
    assert not [cell for cell in written if cell.lstrip().startswith(("=", "+", "@"))]


# -------------------------------------------------------------------- charts: on the page and alone
NASTY = "<b>$x_1$ & \\frac{1}{2}"


def test_a_picture_of_numbered_colours_is_read_by_another_library():
    """Its PNG is written without Pillow, which takes longer to import than the picture to draw."""
    pixels = np.arange(15, dtype=np.uint8).reshape(3, 5) % 4
    colours = ("#ff0000", "#00ff00", "#0000ff", "#123456")
    with Image.open(io.BytesIO(_png(pixels, colours))) as picture:
        assert picture.mode == "P"
        np.testing.assert_array_equal(np.asarray(picture), pixels)
        palette = np.reshape(picture.getpalette(), (-1, 3))[: len(colours)]
    assert ["#{:02x}{:02x}{:02x}".format(*colour) for colour in palette] == list(colours)


@pytest.mark.parametrize(
    "values", [{"strech": "path"}, {"stretch": "path", "n_column": 1}, {}], ids=str
)
def test_a_misspelt_or_missing_value_of_a_caption_is_refused(values: dict[str, object]) -> None:
    assert figure_with_texts("slip_history", [], {}, stretch="path").caption
    with pytest.raises((TypeError, UndefinedError), match=r"stretch|strech|n_column"):
        figure_with_texts("slip_history", [], {}, **values)  # type: ignore[arg-type]


def plate(name: str = "all") -> Plate:
    """A figure with every kind of mark, words from outside and a subscript."""
    x = np.linspace(0.0, 1.0, 5)
    marks = [
        Band(x, 0 * x, x, "pale-stick", "band"),
        Block((0.2, 0.4), (0.1, 0.3), fill="#123456", is_hatched=True),
        Segments(np.array([[[0.0, 0.0], [1.0, 1.0]]]), "curve faint"),
        Rule(0.5, "zero"),
        Curve(x, np.where(x == 0.5, np.nan, x**2), "c1 dash", NASTY),
        Group((Dot(0.5, 0.5, "event"),), "strip", {"strip": 0}),
        Arrow((0.1, 0.1), (0.3, 0.6)),
        Note(0.5, 0.9, NASTY),
    ]
    plain = Panel(
        "plain",
        Axis(0.0, 1.0, "x / a_ref"),
        Axis(0.0, 1.0, NASTY),
        marks,
        NASTY,
        notes=["rms 1 % of p_ref"],
    )
    log = Panel(
        "log",
        Axis(0.1, 10.0, "x", log=True),
        Axis(1e-3, 1.0, "y", log=True),
        [Curve(x + 0.1, x + 1e-3, "c0")],
        "log",
    )
    bitmap = Bitmap(np.eye(3, dtype=np.uint8), ("#ff0000", "#00ff00"))
    pixels = Panel("map", Axis(0.0, 1.0, "x"), Axis(0.0, 1.0, "y"), [bitmap], "map")
    keys = Key("c1 dash", NASTY), Key("pale-stick", "band", True)
    return Plate(name, NASTY, "", "", (plain, Cell((log, pixels), 3)), {"x": x}, keys)


def test_subscripts_are_set_all_else_is_escaped_and_looks_are_those_of_a_light_page() -> None:
    rendered = {
        "x / a_ref": "x / a<sub>ref</sub>",
        "r_fine.csv, h_0.05.csv": "r_fine.csv, h_0.05.csv",
        "A f² P_ref²": "A f² P<sub>ref</sub>²",
        "‖p_ref‖ <b>": "‖p<sub>ref</sub>‖ &lt;b&gt;",
        "my_scene": "my_scene",
        "": "",
    }
    assert {text: marked(text) for text in rendered} == rendered
    expected = {
        "stroke": "#a83400",
        "stroke-width": "1.3",
        "stroke-dasharray": "6 2.5",
        "fill": "none",
    }
    assert expected.items() <= dict(style_of("curve f q")).items()
    assert style_of("body lower")["fill"] == "#cfe3f2"
    assert style_of("title", text=True)["font-size"] == "13"  # not that of a phone


def test_every_figure_stands_alone_and_can_be_published() -> None:
    """No variable of the page, no class of it, nothing of other figures, and XML that any reader
    takes, with its own words.
    """
    compared = compare(TRUTH, with_fields(TRUTH, shear=0.99 * TRUTH.shear))
    alone_by_name = {
        drawing.name: figure(compared, drawing.name) for drawing in draw(Report(compared))
    }
    assert all(len(alone) > 2000 for alone in alone_by_name.values())
    for alone in (*alone_by_name.values(), plate().svg()):
        root = ET.fromstring(alone)
        assert root.tag.endswith("svg")
        assert not [
            word
            for word in ("var(", "<use", "class=", "data-", "{{")
            if word in alone.replace("data:image/png", "")
        ]
    words = [
        "".join(element.itertext()) for element in root.iter("{http://www.w3.org/2000/svg}text")
    ]
    assert "x / aref" in words
    # its subscript is set
    assert (words.count(NASTY), words.count(NASTY.replace("_", ""))) == (0, 3)
    assert "#123456" in alone
    assert alone == plate().svg()


def test_a_script_gets_each_figure_by_the_name_of_its_values(
    comparison: Comparison, tmp_path: Path
) -> None:
    """Those of the page in a report's folder, and a sentence with the names for any other."""
    write(comparison, tmp_path / "out")
    names = {path.stem for path in (tmp_path / "out" / "figures").glob("*.csv")}
    assert names == FIGURES
    drawn = {drawing.name: drawing for drawing in draw(Report(comparison))}
    for name in names:
        assert figure(comparison, name) == figure(Report(comparison), name) == drawn[name].svg()
    with pytest.raises(
        InputError,
        match=r"'traction' is no figure of this comparison; its figures are .*\btractions\b",
    ):
        figure(comparison, "traction")


def test_every_plot_of_a_difference_carries_its_number() -> None:
    """5 % more pressure: rms and the largest are those of p/p_ref, and the place is where p is
    largest.
    """
    plates = {
        p.name: p
        for p in draw(Report(compare(TRUTH, with_fields(TRUTH, pressure=1.05 * TRUTH.pressure))))
    }
    cell = plates["tractions"].panels[0]
    assert isinstance(cell, Cell)
    p, q = cell.panels[1].notes
    # Hertz: the mean of p^2/p0^2 is 2/3, of 47 points 0.654.
    assert p == "p: rms 4 %, largest 5 % at x = 0 a_ref"
    assert q.startswith("q: rms 0 %, largest 0 % at")
    noted = {
        name
        for name, plate in plates.items()
        for stack in panel_stacks_of(plate)
        for panel in stack
        if panel.notes
    }
    assert {
        "tractions",
        "cycle",
        "half_widths",
        "slip_history",
        "dissipation_density",
        "hysteresis",
    } <= noted
    assert "they differ" in plates["state_map"].panels[2].title  # type: ignore[union-attr]


# ------------------------------------------------------------------------------- compiled templates


def compiled_by_jinja(source: str, monkeypatch: pytest.MonkeyPatch) -> tuple[str, int]:
    """What a template says, by an environment of its own, and how many were compiled for it."""
    compiled = []
    as_it_was = templating.Environment.compile

    def compile_and_count(self, *arguments, **options):
        compiled.append(arguments)
        return as_it_was(self, *arguments, **options)

    with monkeypatch.context() as patch:
        patch.setattr(templating.Environment, "compile", compile_and_count)
        sources = templating.FunctionLoader({"a.html": source, "a.css": "b {}"}.get)
        pages = templating.Environment(loader=templating.CompiledTemplates([sources]))
        said = (
            pages.get_template("a.html").render(name="pad") + pages.get_template("a.css").render()
        )
    return said, len(compiled)


def test_templates_are_compiled_once_and_again_where_their_text_or_jinja_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As Python compiles modules: never into a folder that cannot be written, nor where Python is
    told not to.
    """
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert compiled_by_jinja("A {{ name }} ", monkeypatch) == ("A pad b {}", 2)
    assert not list(tmp_path.rglob("*.pyc"))
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    assert compiled_by_jinja("A {{ name }} ", monkeypatch) == ("A pad b {}", 2)
    assert len(list(tmp_path.rglob("*.pyc"))) == 2
    assert compiled_by_jinja("A {{ name }} ", monkeypatch) == ("A pad b {}", 0)
    assert compiled_by_jinja("O {{ name }} ", monkeypatch) == ("O pad b {}", 1)
    assert compiled_by_jinja("O {{ name }} ", monkeypatch) == ("O pad b {}", 0)
    monkeypatch.setattr(templating.jinja2, "__version__", "99")
    assert compiled_by_jinja("O {{ name }} ", monkeypatch) == ("O pad b {}", 2)
    for file in tmp_path.rglob("*.pyc"):
        file.write_bytes(file.read_bytes()[:9])  # half of it
    assert compiled_by_jinja("O {{ name }} ", monkeypatch) == ("O pad b {}", 2)
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "file"))
    (tmp_path / "file").write_text("no folder")
    assert compiled_by_jinja("O {{ name }} ", monkeypatch) == ("O pad b {}", 2)
