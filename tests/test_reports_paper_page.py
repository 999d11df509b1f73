"""What `halfplane paper` writes: every figure in three forms, both tables, a page that needs nothing from outside."""

import csv
import re
from pathlib import Path

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from reports.charts.marks import Band, Curve, Note
from reports.charts.plate import Panel, Plate
from reports.charts.publication import figure_of
from reports.cli import main
from reports.console import Stages
from reports.paper import page as paper
from reports.paper.cases import LETTERS, Paper
from reports.paper.figures import sheets
from scenes import InputError

FIGURES = ("01", "02", "03", "04a", "04b", "05", "06", "07a", "07b", "08", "09", "10a", "10b")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> paper.PaperReport:
    return paper.write(tmp_path_factory.mktemp("paper") / "out", Stages(quiet=True), "halfplane paper --out out")


@pytest.fixture(scope="module")
def page(report: paper.PaperReport) -> str:
    return report.page.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def described() -> dict[str, Plate]:
    return {sheet.name: sheet for sheet in sheets(paper.paper())}


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_every_figure_in_every_form(report: paper.PaperReport) -> None:
    folder = report.page.parent
    for name in FIGURES:
        assert (folder / "figures" / f"figure_{name}.svg").read_text(encoding="utf-8").startswith("<svg xmlns=")
        assert (folder / "figures" / f"figure_{name}.png").read_bytes().startswith(b"\x89PNG")
        assert rows(folder / "figures" / f"figure_{name}.csv")


def test_tables_as_csv(report: paper.PaperReport) -> None:
    folder = report.page.parent
    assert [row["verdict"] for row in rows(folder / "statements.csv")] == [row.verdict.value for row in report.statements]
    assert {row["proven"] for row in rows(folder / "misprints.csv")} == {"yes", "by reading"}
    assert report.proven


def test_page_is_small_and_alone(report: paper.PaperReport, page: str) -> None:
    assert report.page.stat().st_size < 7e5  # measured: 0.56 MB
    assert not re.search(r'(src|href)="(https?:)?//', page)
    assert not re.search(r"<(link|script|iframe|img)[^>]+(src|href)=", page)
    assert page.count("<script>") == 1
    assert "script-src 'sha256-" in page


def test_page_has_everything(report: paper.PaperReport, page: str) -> None:
    for name in FIGURES:
        assert page.count(f'<figure id="figure_{name}"') == 1
    for row in (*report.statements, *report.misprints):
        assert row.key.replace("'", "&#39;") in page
    assert "halfplane paper --out out" in page


def test_identifiers_of_the_drawings_do_not_meet(page: str) -> None:
    found = re.findall(r'\bid="([^"]+)"', page)
    assert len(found) == len(set(found))


def panels(plate: Plate) -> list[Panel]:
    return [panel for panel in plate.panels if isinstance(panel, Panel)]


def test_every_curve_of_a_figure_is_on_the_page_and_every_label_in_its_legend(page: str, described: dict[str, Plate]) -> None:
    for name, plate in described.items():
        figure = page[page.index(f'<figure id="{name}"') :]
        figure = figure[: figure.index("</figure>")]
        marks = [mark for panel in panels(plate) for mark in panel.marks]
        drawn = figure[figure.index('<div class="panels') :]
        assert drawn.count('class="curve ') >= sum(isinstance(mark, Curve) for mark in marks)
        assert drawn.count('class="band ') == sum(isinstance(mark, Band) for mark in marks)
        labels = {mark.label for mark in marks if isinstance(mark, Curve | Band) and mark.label}
        assert labels <= {key.text for key in plate.keys}
        # A click on the legend finds a curve by its look: two labels of one figure must not share it.
        assert len({key.css for key in plate.keys}) == len(plate.keys), name


def test_letters_are_all_on_figure_2(described: dict[str, Plate]) -> None:
    texts = [mark.text for mark in panels(described["figure_02"])[0].marks if isinstance(mark, Note)]
    assert set("".join(texts)) >= set(LETTERS) | {"O", "T", "Z"}
    assert [panel.title[0] for panel in panels(described["figure_03"])] == list(LETTERS)


def test_every_axis_has_a_name(described: dict[str, Plate]) -> None:
    for plate in described.values():
        for panel in panels(plate):
            assert panel.bare or (panel.x.words and panel.y.words), panel.name


@pytest.mark.parametrize("name", FIGURES)
def test_no_text_lies_over_text_or_is_cut_off(described: dict[str, Plate], name: str) -> None:
    figure = figure_of(described[f"figure_{name}"])
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    boxes = [(text.get_text(), text.get_window_extent(canvas.get_renderer())) for text in _drawn(figure)]
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


def test_the_figures_are_about_an_ellipse(described: dict[str, Plate]) -> None:
    from reports.paper.cases import Case
    from scenes import load_scene

    with pytest.raises(InputError, match="an ellipse, not polygon"):
        _ = Case(load_scene("cattaneo-mindlin")).load


def test_costly_parts_are_done_once() -> None:
    examples: Paper = paper.paper()
    assert examples.sweeps is examples.sweeps
    assert examples.peaks is examples.peaks
