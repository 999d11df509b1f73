"""The folder of a report: whole or not at all, strict JSON, a page that needs no network; the PDF; what a notebook shows."""

import csv
import importlib.util
import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import semi_analytic
from reports import Report, compare, write
from reports.cli.solving import summary_rows
from reports.comparison import Comparison
from reports.comparison.words import value_of
from reports.folder import MANIFEST
from reports.page import pdf
from reports.page.writing import draw
from scenes import ContactSolution, InputError, Scene, load_scene, scene_names
from test_reports_synthetic import cattaneo_mindlin, with_fields

TRUTH = cattaneo_mindlin(steps_per_leg=12, points=61)
FIGURES = {
    "bodies",
    "cycle",
    "slip_history",
    "tractions",
    "load_path",
    "hysteresis",
    "half_widths",
    "state_map",
    "dissipation_density",
    "errors",
    "certificates_reference",
    "certificates_result",
}


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    """A result 1 % high in pressure, with an engine's name and a note that a page must escape."""
    result = with_fields(TRUTH, pressure=1.01 * TRUTH.pressure, engine="somebody's <b>code</b>")
    return compare(TRUTH, result, polygon_reference=TRUTH)


@pytest.fixture(scope="module")
def folder(comparison: Comparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report") / "deep" / "out"
    page = write(comparison, out, command="halfplane run 'my scene.toml'", seconds={"finite elements": 1.5})
    assert page == out / "report.html"
    return out


def read_json(path: Path) -> dict:
    """Strict: the words NaN and Infinity, which Python's reader takes, are refused."""

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_everything_is_there(folder: Path) -> None:
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    tables = {f"figures/{name}.csv" for name in FIGURES}
    assert tables <= files
    assert files - tables == {"report.html", "comparison.json", "reference.nc", "result.nc", "scene.json", MANIFEST}
    assert set(read_json(folder / MANIFEST)["files"]) == files


def test_json_holds_the_verdict(folder: Path, comparison: Comparison) -> None:
    stored = read_json(folder / "comparison.json")
    assert (stored["verdict"]["passed"], stored["metrics"]["peak_pressure"]["accurate"]) == (False, False)
    assert stored["metrics"]["peak_pressure"]["value"] == pytest.approx(0.01)
    assert set(stored["metrics"]) == {metric.key for metric in comparison.metrics}
    assert len(stored["metrics"]["shear"]["series"]) == len(stored["instants"])
    assert stored["command"] == "halfplane run 'my scene.toml'"


def test_what_is_not_finite_becomes_null_and_is_said(tmp_path: Path) -> None:
    pressure = TRUTH.pressure.copy()
    pressure[3, 30] = np.nan
    write(compare(TRUTH, with_fields(TRUTH, pressure=pressure, dissipation=np.inf)), tmp_path / "out")
    stored = read_json(tmp_path / "out" / "comparison.json")
    for key in ("pressure", "dissipation"):
        assert stored["metrics"][key]["value"] is None
        assert stored["metrics"][key]["finite"] is False
        assert stored["metrics"][key]["accurate"] is False
    assert stored["metrics"]["shear"]["finite"] is True


def test_solutions_and_scene_can_be_read_back(folder: Path) -> None:
    stored = ContactSolution.load(folder / "reference.nc")
    assert np.array_equal(stored.shear, TRUTH.shear)
    assert compare(stored, TRUTH).passed
    assert (folder / "scene.json").read_text(encoding="utf-8").startswith("{")


def test_tables_hold_what_the_figures_draw(folder: Path, comparison: Comparison) -> None:
    for drawing in draw(Report(comparison)):
        with (folder / "figures" / f"{drawing.name}.csv").open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
        assert list(rows[0]) == list(drawing.table)
        for name, column in drawing.table.items():
            if not isinstance(column[0], str):
                found = [float(row[name]) if row[name] else np.nan for row in rows]
                assert np.array_equal(found, np.asarray(column, dtype=float), equal_nan=True), name
        if drawing.name == "state_map":
            heading = "state_reference (0 open, 1 stick, 2 forward slip, 3 reverse slip)"
            stored = np.array([int(row[heading]) for row in rows]).reshape(len(TRUTH.time), -1)
            assert np.array_equal(stored, TRUTH.state[:, np.abs(TRUTH.x) <= 1.12])


def test_with_bulk_stress_and_tilt_page_file_and_console_name_them_and_both_works(tmp_path: Path, folder: Path) -> None:
    """P = 3, Q = +-1.8, eps = +-0.3 (E* = R = f = 1): W in closed form; where U alone is drawn, nobody may take it for that."""
    work = 0.9368781396315213
    load = {"kind": "polygon", "initial_loading": [(3.0, 0.0), (3.0, 1.8)], "cycle": [(3.0, -1.8)]}
    load |= {"bulk_stress_lower": (0.0, 0.6, -0.6), "tilt": 0.0}
    soft, profile = {"young_modulus": 2.0, "poisson_ratio": 0.0}, {"kind": "hertz", "radius": 1.0}
    scene = Scene.model_validate({"material": soft, "profile": profile, "friction": 1.0, "load": load})
    exact = semi_analytic.solve(scene, x=np.linspace(-2.4, 2.4, 81), time=np.linspace(4.0, 6.0, 161))
    comparison = compare(exact, exact)
    write(comparison, tmp_path / "out")
    content, plain = (read_json(path / "comparison.json") for path in (tmp_path / "out", folder))
    assert (
        "the lower body is under a bulk stress from −0.6 to 0.6 MPa along x; the upper body is tilted by 0 rad"
        in content["question"]
    )
    assert " under bulk stress and tilt" in content["headline"]
    assert "bulk" not in plain["question"] + plain["headline"]
    answer = content["reference"]
    assert answer["loop_work"] == pytest.approx(work, rel=1e-10)
    assert (answer["permanent_stick_left"], answer["permanent_stick_right"]) == pytest.approx((-0.93607744, 1.53607744), abs=1e-7)
    beside = {"bulk_work", "permanent_stick_left", "permanent_stick_right"}
    assert beside <= answer.keys()
    assert not beside & plain["reference"].keys()
    # Both works by the rows of the figure's table, and their sum.
    rows = list(csv.DictReader((tmp_path / "out" / "figures" / "hysteresis.csv").read_text(encoding="utf-8").splitlines()))
    force, shift = (np.array([float(row[name]) for row in rows]) for name in ("Q", "U_reference"))
    loop = float(np.trapezoid(force, shift))
    assert loop + answer["bulk_work"] == pytest.approx(work, rel=1e-3)
    assert abs(loop / work - 1) > 0.1
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for words in ("With bulk stress that is not the dissipation", "of it −∮", "ε = σ/E′", "σ, lower body"):
        assert words in page, words
        assert words not in (folder / "report.html").read_text(encoding="utf-8"), words
    shown = dict(summary_rows(exact))
    assert float(next(shown[name] for name in shown if name.startswith("closed integral of (Q dU - m_q"))) == pytest.approx(work)
    assert any(name.startswith("of it by bulk stress") for name in shown)
    assert not any("m_q" in name for name, _ in summary_rows(TRUTH))


def test_the_map_of_states_and_the_table_say_one_share() -> None:
    sticks = np.where((TRUTH.state > 1) & (TRUTH.x > 0), 1, TRUTH.state).astype(TRUTH.state.dtype)
    found = compare(TRUTH, with_fields(TRUTH, state=sticks), polygon_reference=TRUTH)
    assert found.metric("state").value
    captions = {plate.name: plate.caption for plate in draw(Report(found))}
    assert f" They differ over {value_of(found.metric('state'))} of the length in contact" in captions["state_map"]


class Tags(HTMLParser):
    """Every tag with its attributes, and the text."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text.append(data)


@pytest.fixture(scope="module")
def page(folder: Path) -> Tags:
    tags = Tags()
    tags.feed((folder / "report.html").read_text(encoding="utf-8"))
    return tags


def test_page_needs_no_network(page: Tags, folder: Path) -> None:
    """Figures are inside; every other address is a file of the folder or a place on the page."""
    places = {attributes["id"] for _, attributes in page.found if "id" in attributes}
    names = ("src", "href", "action", "data", "poster", "srcset")
    for address in (value for _, attributes in page.found for name in names if (value := attributes.get(name))):
        if address.startswith("#"):
            assert address[1:] in places
        elif not address.startswith("data:image/png;base64,"):
            assert (folder / address).is_file(), address
    assert not {tag for tag, _ in page.found} & {"link", "iframe", "object", "embed"}
    assert len([tag for tag, _ in page.found if tag == "script"]) == 2  # the data and the page's own
    assert "@import" not in (folder / "report.html").read_text(encoding="utf-8")
    assert (folder / "report.html").stat().st_size < 8e6


def test_page_says_what_it_is_and_is_not(page: Tags) -> None:
    text = " ".join(" ".join(page.text).split())
    sentences = ("two codes agreeing is not validation", "Not within tolerance.", "halfplane run 'my scene.toml'", "not assessed")
    for words in (*sentences, "Through the cycle", "Stick and slip", "Dissipation of a cycle", "Admissible", "Work"):
        assert words in text


def test_page_has_every_figure_with_words_for_it(page: Tags) -> None:
    figures = [attributes for tag, attributes in page.found if tag == "figure"]
    assert len(figures) == len(FIGURES)
    panels = [attributes for tag, attributes in page.found if tag == "svg" and attributes.get("role") == "img"]
    assert len(panels) > len(FIGURES)
    assert all(attributes["aria-label"] for attributes in (*figures, *panels))
    identities = [attributes["id"] for _, attributes in page.found if "id" in attributes]
    assert len(identities) == len(set(identities))


class TestPdf:
    """Made where typst is, refused in a sentence where it is not, words from outside as data and never as typst's language."""

    def test_without_typst_the_extra_is_named(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(pdf, "find_spec", lambda name: None)
        with pytest.raises(InputError, match=r"--pdf: it needs typst.*halfplane\[pdf\]"):
            pdf.require_typst()

    @pytest.mark.skipif(importlib.util.find_spec("typst") is None, reason="typst is not installed: pip install -e .[pdf]")
    def test_a_pdf_is_written_beside_the_page_whatever_the_words(self, folder: Path, tmp_path: Path) -> None:
        nasty = '#panic("typst read this") $x$ *b* `code` <label> @ref \\ // </text>'
        truth = replace(TRUTH, scene=TRUTH.scene.vary(name=nasty, title=nasty, purpose=nasty))
        comparison = compare(truth, with_fields(truth, shear=0.99 * truth.shear, engine=nasty))
        write(comparison, tmp_path / "out", command=nasty, pdf=True)
        content = (tmp_path / "out" / "report.pdf").read_bytes()
        assert content.startswith(b"%PDF-")
        assert len(content) > 50_000
        assert not (folder / "report.pdf").exists()
        # Of real bodies without a tolerance nothing is judged: it was an internal error.
        blocks = with_fields(TRUTH, scene=TRUTH.scene.vary(bodies=load_scene("blocks").bodies, tolerances={}))
        unjudged = compare(blocks, blocks)
        assert unjudged.verdict is None
        write(unjudged, tmp_path / "open", pdf=True)
        assert (tmp_path / "open" / "report.pdf").is_file()


class TestNotebook:
    """Well-formed HTML in which every word from outside is escaped."""

    @pytest.mark.parametrize("name", scene_names())
    def test_every_scene_of_the_library(self, name: str) -> None:
        scene = load_scene(name)
        shown = ET.fromstring(scene._repr_html_())
        assert scene.title in "".join(shown.itertext())
        assert len(shown.findall(".//tr")) == 10 + scene.load.has_bulk_or_tilt
        [line] = [element for element in shown.iter() if element.tag.endswith("path") and len(element.get("d", "")) > 20][:1]
        assert line is not None

    def test_a_solution_with_its_loop_and_a_comparison_with_its_verdict(self, comparison: Comparison) -> None:
        solution = semi_analytic.solve(load_scene("hertz-paper"))
        words = "".join(ET.fromstring(solution._repr_html_()).itertext())
        assert f"{solution.dissipation:.6g}" in words
        assert "semi_analytic" in words
        shown = ET.fromstring(comparison._repr_html_())
        words = "".join(shown.itertext())
        assert "Not within tolerance." in words
        assert "outside" in words
        assert len(shown.findall(".//tr")) == 1 + len(comparison.headlines)

    def test_words_from_outside_are_escaped(self) -> None:
        nasty = "<script>alert(1)</script>\"'&"
        scene, nothing = TRUTH.scene.vary(name=nasty, title=nasty, units=nasty), np.full(len(TRUTH.time), np.nan)
        truth = with_fields(TRUTH, scene=scene, engine=nasty, tangential_displacement=nothing)
        for shown in (scene, truth, compare(truth, truth)):
            html = shown._repr_html_()
            assert nasty in "".join(ET.fromstring(html).itertext())
            assert "<script" not in html
