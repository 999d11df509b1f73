"""A figure of each quantity of a sweep: a line with uncertainty over one axis, a map over two, points where there is no grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.charts import marks
from reports.charts.marks import Band, Block, Curve, Dot, Mark, Rule
from reports.charts.plate import Cell, Key, Panel, Plate, colour_scale
from reports.charts.scale import labels, limits
from reports.charts.style import shades
from reports.sweep.axes import Axis
from reports.sweep.figures import axis_label, is_error
from reports.sweep.index import Table
from reports.units import number
from scenes import Scene

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# Panels of one figure; points of a line that are marked one by one.
_PANELS, _MARKED = 6, 120
_LOOKS = 6


@dataclass(frozen=True)
class Sheet:
    """One figure of a table, ready to be drawn: values, uncertainties (NaN where there is none) and coordinates, (n,) each.

    `words` are the figure's on its axis, with its unit.
    """

    name: str
    value: Array
    uncertainty: Array
    table: Table
    axes: dict[str, Axis]
    words: str

    @property
    def unresolved(self) -> NDArray[np.bool_]:
        """Where an error does not stand out of its uncertainty; never for a quantity that is no error."""
        if not is_error(self.name):
            return np.zeros(len(self.value), dtype=bool)
        return np.abs(self.value) <= self.uncertainty

    def label(self, column: str) -> str:
        """Words of an axis."""
        axis = self.axes.get(column)
        if axis is None or column != axis.name:
            return plain(column)
        return plain(axis.label or axis.name) + (f" [{axis.unit}]" if axis.unit else "")

    def logarithmic(self, column: str) -> bool:
        """Whether an axis goes by factors."""
        axis = self.axes.get(column)
        return bool(axis and (axis.logarithmic or (axis.latin_hypercube and axis.latin_hypercube.logarithmic)))

    def axis(self, column: str, *, cells: bool = False) -> marks.Axis:
        """An axis of numbers; its ticks stand at the values themselves where these are few and apart.

        With `cells` it goes half a step beyond the outer values: a cell of a map is one value.
        """
        values, log = np.unique(self.table.numbers(column)), self.logarithmic(column)
        at = np.log(values) if log else values
        apart = (log or cells) and len(values) <= 8 and np.all(np.diff(at) > 0.04 * np.ptp(at))
        ends = borders_of(at)[[0, -1]] if cells else np.array(limits(at, margin=0.05))
        low, high = (np.exp(ends) if log else ends).tolist()
        own = tuple(zip(values.tolist(), labels([float(f"{value:.3g}") for value in values]), strict=True)) if apart else ()
        return marks.Axis(low, high, self.label(column), log, ticks=own)


def plain(name: str) -> str:
    """A name of a program as words."""
    return name.replace("_", " ")


def plain_figures(table: Table) -> list[str]:
    """The figures without what is said about them."""
    return [name for name in table.figures if not name.endswith((".uncertainty", ".idealisation"))]


def draw(table: Table, axes: Sequence[Axis], scene: Scene) -> list[Plate]:
    """A figure of each quantity that has values, in the units of the `scene` that the sweep varies."""
    found = table.done()
    named = {column: axis for axis in axes for column in axis.columns}
    plates = []
    for name in plain_figures(found):
        shown = f"{name}.idealisation" if f"{name}.idealisation" in found.figures else name
        doubt = f"{name}.uncertainty"
        uncertainty = found.numbers(doubt) if doubt in found.figures else np.full(len(found.rows), np.nan)
        sheet = Sheet(name, found.numbers(shown), uncertainty, found, named, plain(axis_label(name, scene)))
        if np.isfinite(sheet.value).any():
            plates.append(_plate(sheet, shown))
    return plates


def _plate(sheet: Sheet, shown: str) -> Plate:
    moving, sorts = _columns(sheet.table)
    stem, title = shown.replace(".", "-"), plain(shown)
    csv = {**{column: sheet.table.numbers(column) for column in moving}, shown: sheet.value, "uncertainty": sheet.uncertainty}
    if not moving:
        words = f"{number(float(sheet.value[0]))}: the sweep has one point on every axis of numbers"
        return Plate(stem, title, words, words, (), csv)
    keys = [", ".join(f"{name} = {row[name]}" for name in sorts) for row in sheet.table.rows]
    parts = sorted(set(keys))
    masks = [np.array([key == part for key in keys]) for part in parts[:_PANELS]]
    legend: tuple[Key, ...] = ()
    panels: list[Panel | Cell]
    if len(moving) == 1:
        panels, how = [_line(sheet, stem, masks, parts, moving[0])], "bars are its uncertainty; hollow: not resolved"
        legend = tuple(Key(f"line-{k}", plain(part)) for k, part in enumerate(parts[:_PANELS]) if part)
    elif len(moving) == 2 and _is_grid(sheet.table, moving):
        how = "hatched: unresolved, the error is less than its uncertainty; grey: no result"
        panels = [_map(sheet, f"{stem}-{k}", here, moving, part) for k, (here, part) in enumerate(zip(masks, parts, strict=False))]
    else:
        how = "hollow: unresolved; colour: the second axis"
        panels = [
            _cloud(sheet, f"{stem}-{k}", here, moving, part) for k, (here, part) in enumerate(zip(masks, parts, strict=False))
        ]
    left = f" {len(parts) - _PANELS} more sets of the other axes are in index.csv." if len(parts) > _PANELS else ""
    bars = how if np.isfinite(sheet.uncertainty).any() else "without uncertainty"
    caption = f"Over {' and '.join(sheet.label(m) for m in moving[:2])}; {bars}.{left}"
    return Plate(stem, title, caption, f"{title}. {caption}", tuple(panels), csv, legend, min(2, len(panels)))


def _columns(table: Table) -> tuple[list[str], list[str]]:
    """Axes of numbers that move, and those of words that do."""
    values = {name: {row[name] for row in table.rows} for name in table.axes}
    words = [name for name, found in values.items() if any(isinstance(value, str | bool) for value in found)]
    return [n for n in values if len(values[n]) > 1 and n not in words], [n for n in words if len(values[n]) > 1]


def _is_grid(table: Table, moving: Sequence[str]) -> bool:
    """Whether most places of the product of both axes are taken."""
    counts = [len({row[name] for row in table.rows}) for name in moving]
    places = {tuple(row[name] for name in moving) for row in table.rows}
    return len(places) > 0.3 * counts[0] * counts[1]


def bars(x: Array, low: Array, high: Array, look: str) -> Curve:
    """Upright lines from `low` to `high` at each x."""
    gap = np.full(len(x), np.nan)
    return Curve(np.column_stack([x, x, gap]).ravel(), np.column_stack([low, high, gap]).ravel(), f"{look} bar-line")


def _line(sheet: Sheet, name: str, masks: Sequence[Mask], parts: Sequence[str], moving: str) -> Panel:
    drawn: list[Mark] = [Rule(0.0, "zero")] if is_error(sheet.name) else []
    for k, here in enumerate(masks):
        x = sheet.table.numbers(moving)[here]
        order = np.argsort(x)
        x, y, doubt = x[order], sheet.value[here][order], np.nan_to_num(sheet.uncertainty[here][order])
        hollow, look = sheet.unresolved[here][order], f"line-{k % _LOOKS}"
        drawn.append(Curve(x, y, look, plain(parts[k]) or plain(sheet.name)))
        if len(x) > _MARKED:  # a band and no marks: the page stays small
            drawn.insert(0, Band(x, y - doubt, y + doubt, f"p{k % _LOOKS} pale"))
        else:
            drawn.append(bars(x, y - doubt, y + doubt, look))
            drawn += [Dot(float(a), float(b), f"{look} p{k % _LOOKS}", 3.0) for a, b in zip(x[~hollow], y[~hollow], strict=True)]
        drawn += [Dot(float(a), float(b), f"{look} hollow", 3.0) for a, b in zip(x[hollow], y[hollow], strict=True)]
    doubt = np.nan_to_num(sheet.uncertainty)
    up = limits(sheet.value - doubt, sheet.value + doubt, zero=is_error(sheet.name))
    return Panel(
        name,
        sheet.axis(moving),
        marks.Axis(*up, sheet.words),
        drawn,
        f"{plain(sheet.name)} over {sheet.label(moving)}",
        560.0,
        340.0,
    )


def _map(sheet: Sheet, name: str, here: Mask, moving: list[str], part: str) -> Cell:
    columns = [sheet.table.numbers(column) for column in moving]
    logs = [sheet.logarithmic(column) for column in moving]
    edges = []
    for column, log in zip(columns, logs, strict=True):
        steps = np.unique(column)
        edges.append((steps, np.exp(borders_of(np.log(steps))) if log else borders_of(steps)))
    least, most = float(np.nanmin(sheet.value)), float(np.nanmax(np.abs(sheet.value)))
    low, high, colours = (-most, most, "RdBu_r") if least < 0 else (least, float(np.nanmax(sheet.value)), "viridis")
    share = (sheet.value - low) / ((high - low) or 1.0)
    horizontal, vertical = (sheet.axis(column, cells=True) for column in moving)
    drawn: list[Mark] = [Block((horizontal.low, horizontal.high), (vertical.low, vertical.high), "no-value")]
    for row in np.flatnonzero(here & np.isfinite(sheet.value)):
        (left, right), (below, above) = (
            (border[k], border[k + 1])
            for (steps, border), column in zip(edges, columns, strict=True)
            for k in [int(np.searchsorted(steps, column[row]))]
        )
        label = f"{plain(sheet.name)} = {number(float(sheet.value[row]))}" + (", not resolved" if sheet.unresolved[row] else "")
        fill = shades([share[row]], colours)[0]
        drawn.append(Block((float(left), float(right)), (float(below), float(above)), "", label, fill, bool(sheet.unresolved[row])))
    panel = Panel(name, horizontal, vertical, drawn, f"Map of {plain(sheet.name)}, {part}", 480.0, 360.0, plain(part))
    return Cell((panel, colour_scale(f"{name}-colours", low, high, sheet.words, colours)), None)


def _cloud(sheet: Sheet, name: str, here: Mask, moving: list[str], part: str) -> Cell:
    (x, second), axis = (sheet.table.numbers(column) for column in moving[:2]), sheet.axis(moving[0])
    doubt, other = np.nan_to_num(sheet.uncertainty), sheet.axis(moving[1])
    place = (
        (np.log(second / other.low) / np.log(other.high / other.low))
        if other.log
        else (second - other.low) / (other.high - other.low)
    )
    drawn: list[Mark] = [bars(x[here], (sheet.value - doubt)[here], (sheet.value + doubt)[here], "faint")]
    for row in np.flatnonzero(here & np.isfinite(sheet.value)):
        look = "faint hollow" if sheet.unresolved[row] else ""
        label = f"{plain(sheet.name)} = {number(float(sheet.value[row]))}"
        drawn.append(Dot(float(x[row]), float(sheet.value[row]), look, 3.6, label, fill="" if look else shades([place[row]])[0]))
    up = marks.Axis(*limits(sheet.value - doubt, sheet.value + doubt), sheet.words)
    panel = Panel(name, axis, up, drawn, f"{plain(sheet.name)} over {axis.words}, {part}", 480.0, 340.0, plain(part))
    return Cell((panel, colour_scale(f"{name}-colours", other.low, other.high, other.words, log=other.log)), None)


def borders_of(middles: Array) -> Array:
    """Borders half-way between the middles (n,) of cells, and as far beyond the outer ones: (n + 1,).

    >>> borders_of(np.array([1.0, 2.0, 4.0])).tolist()
    [0.5, 1.5, 3.0, 5.0]
    """
    if len(middles) == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    inner = (middles[1:] + middles[:-1]) / 2
    return np.concatenate([[2 * middles[0] - inner[0]], inner, [2 * middles[-1] - inner[-1]]])
