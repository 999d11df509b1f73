"""The figures of a map: errors over its two axes with lines at 1, 5 and 10 %, and over the small parameter with their laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Axis, Block, Curve, Dot, Mark, Note, Segments
from reports.charts.plate import Cell, Key, Panel, Plate, colour_scale
from reports.charts.scale import labels
from reports.charts.style import shades
from reports.maps.atlas import AXES, WORDS, Chart, place
from reports.maps.fitting import Line
from reports.maps.readings import Readings
from reports.sweep.pictures import bars, borders_of

Array = NDArray[np.float64]
_LOOKS = 8
_LEVELS = (1.0, 5.0, 10.0)
_LEAST, _MOST = 0.02, 80.0  # per cent, the colours' ends
_BAR = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_EVEN = ("phase",)
_MARKED = tuple(digit * 10.0**power for power in range(-4, 1) for digit in (1, 2, 5))


def heat(chart: Chart, readings: Readings, figures: Sequence[str]) -> Plate:
    """A row for each figure, a column for each panel; |error| in per cent, hatched where it is not resolved."""
    parts = list(readings.parts((chart.panels,)))
    every = 100 * np.abs(np.concatenate([readings.errors(figure)[0] for figure in figures]))
    low, high = max(_LEAST, float(np.nanmin(every))), min(_MOST, float(np.nanmax(every)))
    panels: list[Panel | Cell] = []
    for number, figure in enumerate(figures):
        for k, (at, part) in enumerate(parts):
            where = ", ".join(f"{AXES.get(name, name)} = {value}" for name, value in at.items())
            title = f"{WORDS[figure]}{'; ' + where if where else ''}"
            panel = _cells(chart, part, figure, f"heat-{number}-{k}", title, (low, high))
            last = number == len(figures) - 1 and k == 0
            bar = (
                [colour_scale("heat-colours", low, high, "|error of half-plane theory|, %", log=True, own=_BAR, width=340.0)]
                if last
                else []
            )
            panels.append(Cell((panel, *bar), None))
    return Plate("map", "", "", "Errors over both axes of a map", tuple(panels), {}, (), len(parts))


def _cells(chart: Chart, part: Readings, figure: str, name: str, title: str, ends: tuple[float, float]) -> Panel:
    error, doubt = part.errors(figure)
    x, y = np.unique(part.numbers(chart.across)), np.unique(part.numbers(chart.up))
    size = np.full((len(y), len(x)), np.nan)
    hidden = np.zeros(size.shape, dtype=bool)
    at = (np.searchsorted(y, part.numbers(chart.up)), np.searchsorted(x, part.numbers(chart.across)))
    size[at], hidden[at] = 100 * np.abs(error), ~(np.abs(error) > doubt)
    # Colours are of cells, lines of the values at their middles; both axes go by factors but for angles.
    across, up = (value if of in _EVEN else np.log(value) for of, value in ((chart.across, x), (chart.up, y)))
    left, below = borders_of(across), borders_of(up)
    marks: list[Mark] = [Block((left[0], left[-1]), (below[0], below[-1]), "no-value")]
    colour = np.log(np.clip(size, *ends) / ends[0]) / np.log(ends[1] / ends[0])
    for j, i in zip(*np.nonzero(np.isfinite(size)), strict=True):
        label = f"{size[j, i]:.3g} %" + (", not resolved" if hidden[j, i] else "")
        cell = (float(left[i]), float(left[i + 1])), (float(below[j]), float(below[j + 1]))
        marks.append(Block(*cell, "", label, shades([colour[j, i]])[0], bool(hidden[j, i])))
    if min(size.shape) > 1:
        # Between points by the logarithm, as errors go by powers.
        height = np.log10(np.maximum(size, 1e-4))
        for level, css in zip(_LEVELS, ("white fine", "white", "white bold"), strict=True):
            lines = contour(across, up, height, float(np.log10(level)))
            if len(lines):
                marks.append(Segments(lines, f"curve {css}"))
                middle = lines[len(lines) // 2].mean(axis=0)
                marks.append(Note(float(middle[0]), float(middle[1]), f"{level:g} %", "tick over", "middle", (0.0, -3.0)))
    horizontal, vertical = (
        Axis(float(borders[0]), float(borders[-1]), AXES.get(of, of), ticks=_ticks(places, values))
        for of, borders, places, values in ((chart.across, left, across, x), (chart.up, below, up, y))
    )
    return Panel(name, horizontal, vertical, marks, title, 340.0, 270.0, title)


def _ticks(at: Array, values: Array) -> tuple[tuple[float, str], ...]:
    every = 1 if len(values) <= 6 else 2
    return tuple((float(a), f"{float(f'{value:.3g}'):g}") for a, value in zip(at[::every], values[::every], strict=True))


def contour(x: Array, y: Array, z: Array, level: float) -> Array:
    """Straight pieces (n, 2, 2) of the line z = level; z (len(y), len(x)), between its points by line, a NaN has no line near it.

    >>> contour(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.array([[0.0, 1.0], [0.0, 1.0]]), 0.25).tolist()
    [[[0.25, 0.0], [0.25, 1.0]]]
    """
    found = []
    for j in range(len(y) - 1):
        for i in range(len(x) - 1):
            corners = [(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)]
            values = [float(z[corner]) for corner in corners]
            if not np.all(np.isfinite(values)):
                continue
            crossings = []
            for (first, a), (last, b) in zip(
                zip(corners, values, strict=True), zip(corners[1:] + corners[:1], values[1:] + values[:1], strict=True), strict=True
            ):
                if (a < level) != (b < level):
                    share = (level - a) / (b - a)
                    ends = np.array([[x[first[1]], y[first[0]]], [x[last[1]], y[last[0]]]])
                    crossings.append(ends[0] + share * (ends[1] - ends[0]))
            # Four crossings are a saddle: neighbours are joined, as if its middle lay below.
            found += [crossings[k : k + 2] for k in range(0, len(crossings), 2)]
    return np.array(found).reshape(-1, 2, 2)


def slopes(chart: Chart, found: Sequence[Line], figures: Sequence[str]) -> Plate:
    """A panel for each figure; |error| over the small parameter, hollow where unresolved, laws, the predicted slope."""
    panels, keys = [], dict[str, Key]()
    for number, figure in enumerate(figures):
        chosen = [line for line in found if line.figure == figure]
        marks = [mark for k, line in enumerate(chosen) for mark in _line(line, k)]
        keys |= {place(line.at, "points"): Key(f"c{k % _LOOKS}", place(line.at, "points")) for k, line in enumerate(chosen)}
        s = np.concatenate([line.s for line in chosen]) if chosen else np.array([0.1, 1.0])
        size = np.concatenate([np.abs(line.error) for line in chosen]) if chosen else np.array([0.01])
        known = np.isfinite(size) & (size > 0)
        low, high = max(50 * float(size[known].min()), 1e-4), 150 * float(size[known].max())
        order = chart.order(figure)
        if chosen and order is not None:
            ends = np.array([s.min(), s.max()])
            others = "".join(f"; {WORDS[name]}: {power:g}" for name, power in chart.others.items())
            label = f"slope {chart.expected:g}, predicted{others}"
            marks.append(Curve(ends, 60 * float(size[known].max()) * (ends / ends[1]) ** order, "slope order-2", label))
            keys[label] = Key("slope order-2", label)
        wanted = [mark for mark in _MARKED if s.min() * 0.9 <= mark <= s.max() * 1.1]
        across = Axis(
            0.9 * float(s.min()), 1.1 * float(s.max()), chart.small, log=True, ticks=tuple(zip(wanted, labels(wanted), strict=True))
        )
        up = Axis(low, high, "|error|, %", log=True)
        panels.append(Panel(f"slopes-{number}", across, up, marks, WORDS[figure], 460.0, 340.0, WORDS[figure]))
    return Plate("law", "", "", "Errors over the small parameter", tuple(panels), {}, tuple(keys.values()), min(2, len(figures)))


def _line(line: Line, number: int) -> Iterator[Mark]:
    look, size, doubt = f"c{number % _LOOKS}", 100 * np.abs(line.error), np.nan_to_num(100 * line.uncertainty)
    low = np.maximum(size - doubt, 1e-3 * size)
    yield bars(line.s, low, size + doubt, look)
    for s, value, hidden in zip(line.s, size, size <= doubt, strict=True):
        if np.isfinite(value):
            yield Dot(float(s), float(value), f"{look} hollow" if hidden else f"p{number % _LOOKS}", 2.8)
    if line.law is not None:
        s = np.geomspace(line.law.smallest, line.law.largest, 40)
        yield Curve(s, [100 * abs(line.law.value(float(here))) for here in s], f"{look} fine", place(line.at, "points"))
