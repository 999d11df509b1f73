"""What `halfplane paper` writes: every figure in three forms, both tables, a page that needs nothing from outside."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from reports.cli import main
from reports.console import Stages
from reports.paper import interactive
from reports.paper import page as paper
from reports.paper.cases import LETTERS, Paper
from reports.paper.plots import Band, Line, Note, Panel, Sheet, draw
from scenes import InputError

FIGURES = ("01", "02", "03", "04a", "04b", "05", "06", "07a", "07b", "08", "09", "10a", "10b")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> paper.PaperReport:
    return paper.write(tmp_path_factory.mktemp("paper") / "out", Stages(quiet=True), "halfplane paper --out out")


@pytest.fixture(scope="module")
def page(report: paper.PaperReport) -> str:
    return report.page.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def described() -> dict[str, Sheet]:
    return {sheet.name: sheet for sheet in paper.sheets(paper.paper())}


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_every_figure_in_every_form(report: paper.PaperReport) -> None:
    folder = report.page.parent
    for name in FIGURES:
        assert (folder / "figures" / f"figure_{name}.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")
        assert (folder / "figures" / f"figure_{name}.png").read_bytes().startswith(b"\x89PNG")
        assert rows(folder / "figures" / f"figure_{name}.csv")


def test_tables_as_csv(report: paper.PaperReport) -> None:
    folder = report.page.parent
    assert [row["verdict"] for row in rows(folder / "statements.csv")] == [row.verdict.value for row in report.statements]
    assert {row["proven"] for row in rows(folder / "misprints.csv")} == {"yes", "by reading"}
    assert report.proven


def test_page_is_small_and_alone(report: paper.PaperReport, page: str) -> None:
    assert report.page.stat().st_size < 8e6
    own = page[: page.index('<script type="application/json"')]
    assert not re.search(r'(src|href)="(https?:)?//', own)
    assert not re.search(r"<(link|script|iframe|img)[^>]+(src|href)=", own)
    assert page.count("plotly.js v") == 1


def test_page_has_everything(report: paper.PaperReport, page: str) -> None:
    for name in FIGURES:
        assert page.count(f'<figure id="figure_{name}">') == 1
    for row in (*report.statements, *report.misprints):
        assert row.key.replace("'", "&#39;") in page
    assert "halfplane paper --out out" in page


def test_identifiers_of_the_drawings_do_not_meet(page: str) -> None:
    own = page[: page.index('<script type="application/json"')]
    found = re.findall(r'\bid="([^"]+)"', own)
    assert len(found) == len(set(found))


def test_interactive_figures_are_strict_json_with_every_curve(page: str, described: dict[str, Sheet]) -> None:
    text = re.search(r'<script type="application/json" id="plots">(.*?)</script>', page, re.DOTALL)
    assert text
    plots = json.loads(text.group(1), parse_constant=pytest.fail)
    assert sorted(plots) == sorted(described)
    for name, sheet in described.items():
        curves = sum(isinstance(part, Line | Band) for panel in sheet.panels for part in panel.parts)
        drawn = [trace for trace in plots[name]["data"] if trace["mode"] == "lines"]
        assert len(drawn) == curves


def test_letters_are_all_on_figure_2(described: dict[str, Sheet]) -> None:
    texts = [part.text for part in described["figure_02"].panels[0].parts if isinstance(part, Note)]
    assert set("".join(texts)) >= set(LETTERS) | {"O", "T", "Z"}
    assert [panel.title[0] for panel in described["figure_03"].panels] == list(LETTERS)


def test_every_axis_has_a_name(described: dict[str, Sheet]) -> None:
    """Of panels in rows the outer ones, as the static figure shares them."""
    for sheet in described.values():
        rows_of_panels = [sheet.panels[k : k + sheet.columns] for k in range(0, len(sheet.panels), sheet.columns)]
        if not sheet.panels[0].bare:
            assert all(row[0].y_label for row in rows_of_panels), sheet.name
            assert all(panel.x_label for panel in sheet.panels[-sheet.columns :]), sheet.name


@pytest.mark.parametrize("name", FIGURES)
def test_no_text_lies_over_text_or_is_cut_off(described: dict[str, Sheet], name: str) -> None:
    drawing = draw(described[f"figure_{name}"])
    canvas = FigureCanvasAgg(drawing.figure)
    canvas.draw()
    boxes = [(text.get_text(), text.get_window_extent(canvas.get_renderer())) for text in _drawn(drawing.figure)]
    width, height = canvas.get_width_height()
    for word, box in boxes:
        assert box.x0 >= -1, word
        assert box.y0 >= -1, word
        assert box.x1 <= width + 1, word
        assert box.y1 <= height + 1, word
    for number, (word, box) in enumerate(boxes):
        for other, beside in boxes[number + 1 :]:
            apart = box.x1 - 1 <= beside.x0 or beside.x1 - 1 <= box.x0 or box.y1 - 1 <= beside.y0 or beside.y1 - 1 <= box.y0
            assert apart, (word, other)


def _drawn(figure: Figure) -> list[Text]:
    """Every text that is drawn: matplotlib keeps labels of ticks beyond the axes too, and all of axes that are switched off."""
    ticks: list[Text] = []
    kept: list[Text] = []
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks += [tick.label1 for tick in (*axis.majorTicks, *axis.minorTicks)]
            if axes.get_visible() and axes.axison:
                kept += [tick.label1 for tick in axis.get_major_ticks() if low - 1e-9 <= tick.get_loc() <= high + 1e-9]
    known = {id(text) for text in ticks}
    rest = [text for text in figure.findobj(Text) if id(text) not in known and (text.axes is None or text.axes.get_visible())]
    return [text for text in (*rest, *kept) if text.get_text().strip() and text.get_visible()]


def test_a_band_with_gaps_becomes_closed_outlines() -> None:
    x = np.arange(5.0)
    high = np.array([1.0, 1.0, np.nan, 2.0, 2.0])
    sheet = Sheet("s", "", "", "", [Panel("x", "y", [Band(x, np.zeros(5), high, "#ccc", "band")])], {"x": x})
    (trace,) = interactive.figure(sheet)["data"]
    assert trace["x"] == [0, 1, 1, 0, None, 3, 4, 4, 3, None]
    assert trace["y"] == [0, 0, 1, 1, None, 0, 0, 2, 2, None]


def test_command_refuses_what_is_not_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "report.html").write_text("mine")
    assert main(["paper", "--out", str(tmp_path), "--quiet"]) == 2
    assert "halfplane did not write it" in capsys.readouterr().err
    assert (tmp_path / "report.html").read_text() == "mine"


def test_exit_code_tells_of_a_misprint_not_proven(
    report: paper.PaperReport, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from dataclasses import replace

    doubted = replace(report, misprints=(replace(report.misprints[0], proven=False), *report.misprints[1:]))
    monkeypatch.setattr(paper, "write", lambda *_: doubted)
    assert main(["paper", "--out", str(tmp_path / "out"), "--quiet"]) == 1
    monkeypatch.setattr(paper, "write", lambda *_: report)
    assert main(["paper", "--out", str(tmp_path / "out"), "--quiet"]) == 0


def test_the_figures_are_about_an_ellipse(described: dict[str, Sheet]) -> None:
    from reports.paper.cases import Case
    from scenes import load_scene

    with pytest.raises(InputError, match="an ellipse, not polygon"):
        _ = Case(load_scene("cattaneo-mindlin")).load


def test_costly_parts_are_done_once() -> None:
    examples: Paper = paper.paper()
    assert examples.sweeps is examples.sweeps
    assert examples.peaks is examples.peaks


def test_interactive_panels_of_figure_3_are_equal(described: dict[str, Sheet]) -> None:
    layout = interactive.figure(described["figure_03"])["layout"]
    for axis in ("xaxis", "yaxis"):
        domains = [value["domain"] for key, value in layout.items() if key.startswith(axis)]
        assert len(domains) == 13
        assert {round(high - low, 9) for low, high in domains} == {round(domains[0][1] - domains[0][0], 9)}
    # Room that an axis takes for its own labels would come off its panel.
    assert not [key for key, value in layout.items() if "axis" in key and value.get("automargin")]
