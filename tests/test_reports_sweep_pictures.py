"""Pictures of a sweep's table: what their axes say."""

from __future__ import annotations

import re
from collections.abc import Sequence

import pytest

from reports.charts.plate import Plate, stacks
from reports.sweep.axes import Axis, Steps
from reports.sweep.index import STATUS, Table
from reports.sweep.pictures import draw
from scenes import load_scene


def picture(x: Sequence[float], y: Sequence[float]) -> str:
    """The SVG of a figure over the product of `x` and `y`."""
    names = ("x", "y")
    rows = tuple(
        {"number": n, "x": a, "y": b, "error.dissipation": a * b, "status": "done"}
        for n, (a, b) in enumerate((a, b) for a in x for b in y)
    )
    columns = ("number", *names, "error.dissipation", *STATUS[1:])
    axes = [Axis(name="x", key="friction.coefficient", values=tuple(x)), Axis(name="y", values=tuple(y))]
    (drawn,) = draw(Table(columns, names, ("error.dissipation",), rows), axes, load_scene("hertz-paper"))
    return first_panel(drawn)


def first_panel(plate: Plate) -> str:
    """The SVG of a figure's first panel on the page."""
    return stacks(plate)[0][0].__html__()


def numbers_on_axes(svg: str, name: str) -> list[str]:
    """Labels of the ticks along x (`across`) or y (`upright`)."""
    return re.findall(rf'<text[^>]*class="tick {name}"[^>]*>([^<]+)</text>', svg)


def test_every_cell_of_a_map_has_a_colour_and_reads_its_value() -> None:
    svg = picture([0.4, 0.6, 0.8], [0.3, 0.6, 0.9])
    assert len(re.findall(r'<rect[^>]*fill="#[0-9a-f]{6}"[^>]*data-label="error.dissipation = ', svg)) == 9


def test_a_map_has_its_ticks_at_the_values_of_the_study() -> None:
    svg = picture([0.4, 0.6, 0.8], [0.3, 0.6, 0.9])
    assert numbers_on_axes(svg, "across") == ["0.4", "0.6", "0.8"]
    assert numbers_on_axes(svg, "upright") == ["0.3", "0.6", "0.9"]


@pytest.mark.parametrize("values", [[0.1, 0.11, 1.0, 5.0], [float(n) for n in range(1, 20)]])
def test_values_too_near_or_too_many_have_the_ticks_of_an_even_axis(values: list[float]) -> None:
    assert numbers_on_axes(picture(values, [1.0, 2.0]), "across") != [f"{value:.3g}" for value in values]


def test_factors_have_theirs() -> None:
    axis = Axis(name="x", logarithmic=Steps(start=1.0, stop=64.0, count=4))
    rows = tuple({"number": n, "x": x, "error.dissipation": x, "status": "done"} for n, x in enumerate([1.0, 4.0, 16.0, 64.0]))
    table = Table(("number", "x", "error.dissipation", *STATUS[1:]), ("x",), ("error.dissipation",), rows)
    (drawn,) = draw(table, [axis], load_scene("hertz-paper"))
    assert numbers_on_axes(first_panel(drawn), "across") == ["1", "4", "16", "64"]
