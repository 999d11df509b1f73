"""Charts: what they may import, words with subscripts, marks that both engines draw alike, files of publication quality."""

from __future__ import annotations

import ast
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from reports import Report, compare
from reports.charts.marks import Arrow, Axis, Band, Bitmap, Block, Curve, Dot, Group, Note, Rule, Segments
from reports.charts.plate import Cell, Key, Panel, Plate, arranged, stacks
from reports.charts.publication import drawn, figure_of, write_plots
from reports.charts.style import marked, style_of
from reports.page.writing import draw
from scenes import load_scene
from test_reports_synthetic import cattaneo_mindlin, with_fields

CHARTS = Path(__file__).parents[1] / "reports" / "charts"
NASTY = "<b>$x_1$ & \\frac{1}{2}"
TRUTH = cattaneo_mindlin(steps_per_leg=12, points=61)


def plate(name: str = "all") -> Plate:
    """A figure with every kind of mark, words from outside and a subscript."""
    x = np.linspace(0.0, 1.0, 5)
    marks = [
        Band(x, 0 * x, x, "pale-stick", "band"),
        Block((0.2, 0.4), (0.1, 0.3), fill="#123456", hatched=True),
        Segments(np.array([[[0.0, 0.0], [1.0, 1.0]]]), "curve faint"),
        Rule(0.5, "zero"),
        Curve(x, np.where(x == 0.5, np.nan, x**2), "c1 dash", NASTY),
        Group((Dot(0.5, 0.5, "event"),), "strip", {"strip": 0}),
        Arrow((0.1, 0.1), (0.3, 0.6)),
        Note(0.5, 0.9, NASTY),
    ]
    plain = Panel("plain", Axis(0.0, 1.0, "x / a_ref"), Axis(0.0, 1.0, NASTY), marks, NASTY, notes=["rms 1 % of p_ref"])
    log = Panel("log", Axis(0.1, 10.0, "x", log=True), Axis(1e-3, 1.0, "y", log=True), [Curve(x + 0.1, x + 1e-3, "c0")], "log")
    bitmap = Bitmap(np.eye(3, dtype=np.uint8), ("#ff0000", "#00ff00"))
    pixels = Panel("map", Axis(0.0, 1.0, "x"), Axis(0.0, 1.0, "y"), [bitmap], "map")
    keys = Key("c1 dash", NASTY), Key("pale-stick", "band", True)
    return Plate(name, NASTY, "", "", (plain, Cell((log, pixels), 3)), {"x": x}, keys)


def test_charts_import_nothing_of_reports_but_charts_and_units() -> None:
    for path in CHARTS.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else [a.name for a in getattr(node, "names", ())]
            if isinstance(node, ast.Import | ast.ImportFrom):
                other = [n for n in names if n.split(".")[0] == "reports" and not n.startswith(("reports.charts", "reports.units"))]
                assert not other, f"{path.name}: {other}"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("x / a_ref", "x / a<sub>ref</sub>"),
        ("A f² P_ref²", "A f² P<sub>ref</sub>²"),
        ("‖p_ref‖ <b>", "‖p<sub>ref</sub>‖ &lt;b&gt;"),
        ("my_scene", "my_scene"),
        ("", ""),
    ],
)
def test_subscripts_are_set_and_all_else_is_escaped(text: str, shown: str) -> None:
    assert marked(text) == shown


def test_looks_are_those_of_the_style_sheet_on_a_light_page() -> None:
    wanted = {"stroke": "#a83400", "stroke-width": "1.3", "stroke-dasharray": "6 2.5", "fill": "none"}
    assert wanted.items() <= dict(style_of("curve f q")).items()
    assert style_of("body lower")["fill"] == "#cfe3f2"
    assert style_of("title", text=True)["font-size"] == "13"  # not that of a phone


def test_a_figure_alone_is_xml_with_its_words_and_its_colours() -> None:
    text = plate().svg()
    root = ET.fromstring(text)
    words = ["".join(element.itertext()) for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert "x / aref" in words
    assert words.count(NASTY) == 0  # its subscript is set
    assert words.count(NASTY.replace("_", "")) == 3
    assert "#123456" in text
    assert not [word for word in ("class=", "var(", "data-key") if word in text]
    assert text == plate().svg()


def test_files_of_publication_quality_are_of_the_same_figure(tmp_path: Path) -> None:
    names = write_plots([plate("one")], tmp_path / "plots", ("pdf", "svg", "png"))
    assert names == ["one.pdf", "one.svg", "one.png"]
    assert (tmp_path / "plots" / "one.pdf").read_bytes().startswith(b"%PDF-")
    assert ET.parse(tmp_path / "plots" / "one.svg").getroot().tag.endswith("svg")
    image = Image.open(tmp_path / "plots" / "one.png").convert("RGB")
    paper = arranged(plate())
    assert image.size == pytest.approx((paper.width / 96 * 200, paper.height / 96 * 200), abs=2)
    colours = {colour for _, colour in image.getcolors(10**7) or []}
    assert {(0x12, 0x34, 0x56), (255, 0, 0), (0, 255, 0), (0xD5, 0x5E, 0x00)} <= colours
    assert drawn(plate("one"), ("svg",))["svg"] == (tmp_path / "plots" / "one.svg").read_bytes()


def test_both_engines_put_the_axes_at_one_place() -> None:
    figure, paper = figure_of(plate()), arranged(plate())
    for axes, (panel, left, top) in zip(figure.axes, paper.panels, strict=True):
        a, b, c, d = panel.frame.box
        box = axes.get_position()
        found = (box.x0 * paper.width, (1 - box.y1) * paper.height, box.x1 * paper.width, (1 - box.y0) * paper.height)
        assert found == pytest.approx((left + a, top + b, left + c, top + d))
        assert axes.get_xlim() == pytest.approx((panel.x.low, panel.x.high))


def test_every_figure_of_a_report_can_be_published_and_stands_alone(tmp_path: Path) -> None:
    """No variable of the page, no class of it, nothing of other figures, and XML that any reader takes."""
    plates = draw(Report(compare(TRUTH, with_fields(TRUTH, shear=0.99 * TRUTH.shear))))
    assert write_plots(plates, tmp_path, ("svg",)) == [f"{plate.name}.svg" for plate in plates]
    for plate in plates:
        assert (tmp_path / f"{plate.name}.svg").stat().st_size > 3000
        alone = plate.svg()
        assert ET.fromstring(alone).tag.endswith("svg")
        assert not [word for word in ("var(", "<use", "class=", "data-", "{{") if word in alone.replace("data:image/png", "")]


def test_every_plot_of_a_difference_carries_its_number() -> None:
    """5 % more pressure: rms and the largest are those of p/p_ref, and the place is where p is largest."""
    plates = {p.name: p for p in draw(Report(compare(TRUTH, with_fields(TRUTH, pressure=1.05 * TRUTH.pressure))))}
    cell = plates["tractions"].panels[0]
    assert isinstance(cell, Cell)
    p, q = cell.panels[1].notes
    # Hertz: the mean of p^2/p0^2 is 2/3, of 47 points 0.654.
    assert p == "p: rms 4 %, largest 5 % at x = 0 a_ref"
    assert q.startswith("q: rms 0 %, largest 0 % at")
    noted = {name for name, plate in plates.items() for stack in stacks(plate) for panel in stack if panel.notes}
    assert {"tractions", "cycle", "half_widths", "slip_history", "dissipation_density", "hysteresis"} <= noted
    assert "they differ" in plates["state_map"].panels[2].title  # type: ignore[union-attr]


def test_errors_of_real_bodies_without_a_tolerance_are_drawn_in_per_cent() -> None:
    blocks = TRUTH.scene.vary(bodies=load_scene("blocks").bodies, tolerances={})
    found = compare(with_fields(TRUTH, scene=blocks), with_fields(TRUTH, scene=blocks, pressure=1.02 * TRUTH.pressure))
    assert found.verdict is None
    (plate,) = (one for one in draw(Report(found)) if one.name == "errors")
    assert {"peak_pressure", "pressure", "contact_edge"} <= set(plate.table)
    assert "Peak pressure, worst instant: 2 % at" in " ".join(key.text for key in plate.keys)
