"""The figures of a map: errors over its two axes with lines at 1, 5 and 10 %, and over the small parameter with their laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from reports.charts.marks import Axis, Block, Curve, Dot, Mark, Note
from reports.charts.plate import Cell, Key, Panel, Plate, colour_scale
from reports.charts.scale import labels
from reports.charts.style import shades
from reports.maps.atlas import AXES, WORDS, Chart, place
from reports.maps.laws import Line, errors, numbers, parts
from reports.sweep.page import bars, borders_of

Array = NDArray[np.float64]
_LOOKS = 8
_LEVELS = {1.0: "white fine", 5.0: "white", 10.0: "white bold"}
_LEAST, _MOST = 0.02, 80.0  # per cent, the colours' ends
_BAR = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_MARKED = tuple(digit * 10.0**power for power in range(-4, 1) for digit in (1, 2, 5))


def heat(chart: Chart, table: pd.DataFrame, shown: Sequence[str]) -> Plate:
    """A row for each error, a column for each panel; |error| in per cent, hatched where it is not resolved."""
    columns = list(parts(table, (chart.panels,)))
    every = 100 * np.abs(np.concatenate([errors(table, figure)[0] for figure in shown]))
    low, high = max(_LEAST, float(np.nanmin(every))), min(_MOST, float(np.nanmax(every)))
    bar = colour_scale("heat-colours", low, high, "|error of half-plane theory|, %", log=True, own=_BAR, width=340.0)
    panels = []
    for number, figure in enumerate(shown):
        for k, (at, part) in enumerate(columns):
            where = ", ".join(f"{AXES.get(name, name)} = {value}" for name, value in at.items())
            title = f"{WORDS[figure]}{'; ' + where if where else ''}"
            panel = _cells(chart, part, figure, f"heat-{number}-{k}", title, (low, high))
            panels.append(Cell((panel, bar) if number == len(shown) - 1 and k == 0 else (panel,), None))
    return Plate("map", "", "", "Errors over both axes of a map", tuple(panels), {}, (), len(columns))


def _cells(chart: Chart, part: pd.DataFrame, figure: str, name: str, title: str, ends: tuple[float, float]) -> Panel:
    """Colours are of cells, lines of the values at their middles; both axes go by factors but for angles and what may be 0."""
    error, doubt = errors(part, figure)
    x, y = np.unique(numbers(part, chart.across)), np.unique(numbers(part, chart.up))
    size, hidden = np.full((len(y), len(x)), np.nan), np.zeros((len(y), len(x)), dtype=bool)
    at = (np.searchsorted(y, numbers(part, chart.up)), np.searchsorted(x, numbers(part, chart.across)))
    size[at], hidden[at] = 100 * np.abs(error), ~(np.abs(error) > doubt)
    across, up = (value if of == "phase" or value[0] <= 0 else np.log(value) for of, value in ((chart.across, x), (chart.up, y)))
    left, below = borders_of(across), borders_of(up)
    marks: list[Mark] = [Block((left[0], left[-1]), (below[0], below[-1]), "no-value")]
    colour = np.log(np.clip(size, *ends) / ends[0]) / np.log(ends[1] / ends[0])
    for j, i in zip(*np.nonzero(np.isfinite(size)), strict=True):
        label = f"{size[j, i]:.3g} %" + (", not resolved" if hidden[j, i] else "")
        cell = (float(left[i]), float(left[i + 1])), (float(below[j]), float(below[j + 1]))
        marks.append(Block(*cell, "", label, shades([colour[j, i]])[0], bool(hidden[j, i])))
    if min(size.shape) > 1:
        marks += _level_lines(across, up, size)
    horizontal, vertical = (
        Axis(float(borders[0]), float(borders[-1]), AXES.get(of, of), ticks=_ticks(places, values))
        for of, borders, places, values in ((chart.across, left, across, x), (chart.up, below, up, y))
    )
    return Panel(name, horizontal, vertical, marks, title, 340.0, 270.0, title)


def _level_lines(across: Array, up: Array, size: Array) -> Iterator[Mark]:
    """Lines at 1, 5 and 10 %, between points by the logarithm, as errors go by powers; none near a point without a value."""
    from matplotlib.figure import Figure

    height = np.ma.masked_invalid(np.log10(np.maximum(size, 1e-4)))
    for level, css in _LEVELS.items():
        if height.min() < np.log10(level) < height.max():
            pieces = Figure().subplots().contour(across, up, height, levels=[np.log10(level)]).allsegs[0]
            for points in pieces:
                yield Curve(points[:, 0], points[:, 1], css)
            longest = max(pieces, key=len)
            middle = longest[len(longest) // 2 - 1 :][:2].mean(axis=0)
            yield Note(float(middle[0]), float(middle[1]), f"{level:g} %", "tick over", "middle", (0.0, -3.0))


def _ticks(at: Array, values: Array) -> tuple[tuple[float, str], ...]:
    every = 1 if len(values) <= 6 else 2
    return tuple((float(a), f"{float(f'{value:.3g}'):g}") for a, value in zip(at[::every], values[::every], strict=True))


def slopes(chart: Chart, found: Sequence[Line], shown: Sequence[str]) -> Plate:
    """A panel for each error; |error| over the small parameter, hollow where unresolved, laws, the predicted slope."""
    panels, keys = [], dict[str, Key]()
    for number, figure in enumerate(shown):
        chosen = [line for line in found if line.figure == figure]
        marks = [mark for k, line in enumerate(chosen) for mark in _line(line, k)]
        keys |= {place(line.at, "points"): Key(f"c{k % _LOOKS}", place(line.at, "points")) for k, line in enumerate(chosen)}
        s, size = (
            np.concatenate([column(line) for line in chosen]) for column in (lambda one: one.s, lambda one: np.abs(one.error))
        )
        known = size[np.isfinite(size) & (size > 0)]
        if (order := chart.order(figure)) is not None:
            ends = np.array([s.min(), s.max()])
            others = "".join(f"; {WORDS[name]}: {power:g}" for name, power in chart.others.items())
            label = f"slope {chart.expected:g}, predicted{others}"
            marks.append(Curve(ends, 60 * float(known.max()) * (ends / ends[1]) ** order, "slope order-2", label))
            keys[label] = Key("slope order-2", label)
        wanted = [mark for mark in _MARKED if s.min() * 0.9 <= mark <= s.max() * 1.1]
        ticks = tuple(zip(wanted, labels(wanted), strict=True))
        across = Axis(0.9 * float(s.min()), 1.1 * float(s.max()), chart.small, log=True, ticks=ticks)
        up = Axis(max(50 * float(known.min()), 1e-4), 150 * float(known.max()), "|error|, %", log=True)
        panels.append(Panel(f"slopes-{number}", across, up, marks, WORDS[figure], 460.0, 340.0, WORDS[figure]))
    return Plate("law", "", "", "Errors over the small parameter", tuple(panels), {}, tuple(keys.values()), min(2, len(shown)))


def _line(line: Line, number: int) -> Iterator[Mark]:
    look, size, doubt = f"c{number % _LOOKS}", 100 * np.abs(line.error), np.nan_to_num(100 * line.uncertainty)
    yield bars(line.s, np.maximum(size - doubt, 1e-3 * size), size + doubt, look)
    for s, value, hidden in zip(line.s, size, size <= doubt, strict=True):
        if np.isfinite(value):
            yield Dot(float(s), float(value), f"{look} hollow" if hidden else f"p{number % _LOOKS}", 2.8)
    if line.law is not None:
        s = np.geomspace(line.law.smallest, line.law.largest, 40)
        yield Curve(s, [100 * abs(line.law.value(float(here))) for here in s], f"{look} fine", place(line.at, "points"))
