"""A drawing of each figure of a sweep: a line with uncertainty over one axis, a map over two, points where there is no grid."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.drawing import literal
from reports.sweep.axes import Axis
from reports.sweep.figures import axis_label, is_error
from reports.sweep.index import Table
from reports.units import minus, number
from scenes import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_PANELS = 6
_MARKED = 120
_COLOURS = ("#0072b2", "#d55e00", "#00795a", "#b5508c", "#9c6a00", "#333333")


@dataclass(frozen=True)
class Picture:
    """An SVG with its words."""

    name: str
    svg: str
    caption: str


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
            return column
        return (axis.label or axis.name) + (f" [{axis.unit}]" if axis.unit else "")

    def logarithmic(self, column: str) -> bool:
        """Whether an axis goes by factors."""
        axis = self.axes.get(column)
        return bool(axis and (axis.logarithmic or (axis.latin_hypercube and axis.latin_hypercube.logarithmic)))


def plain_figures(table: Table) -> list[str]:
    """The figures without what is said about them."""
    return [name for name in table.figures if not name.endswith((".uncertainty", ".idealisation"))]


def draw(table: Table, axes: Sequence[Axis], scene: Scene) -> list[Picture]:
    """A picture of each figure that has values, in the units of the `scene` that the sweep varies."""
    found = table.done()
    named = {column: axis for axis in axes for column in axis.columns}
    pictures = []
    for name in plain_figures(found):
        shown = f"{name}.idealisation" if f"{name}.idealisation" in found.figures else name
        doubt = f"{name}.uncertainty"
        uncertainty = found.numbers(doubt) if doubt in found.figures else np.full(len(found.rows), np.nan)
        sheet = Sheet(name, found.numbers(shown), uncertainty, found, named, axis_label(name, scene))
        if np.isfinite(sheet.value).any():
            pictures.append(_picture(sheet, shown))
    return pictures


def _picture(sheet: Sheet, shown: str) -> Picture:
    moving, sorts = _columns(sheet.table)
    if not moving:
        return Picture(shown, "", f"{shown} = {number(float(sheet.value[0]))}: the sweep has one point on every axis of numbers")
    keys = _parts(sheet.table, sorts)
    panels = sorted(set(keys))[:_PANELS]
    kind: Callable[..., None]
    if len(moving) == 1:
        kind, how = _line, "bars are its uncertainty"
    elif len(moving) == 2 and _is_grid(sheet.table, moving):
        kind, how = _map, "hatched: unresolved, the error is less than its uncertainty; grey: no result"
    else:
        kind, how = _cloud, "hollow: unresolved; colour: the second axis"
    figure, drawings = _paper(len(panels) if kind is not _line else 1)
    limits = float(np.nanmax(np.abs(sheet.value)))
    for place, key in enumerate(panels):
        here = np.array([k == key for k in keys])
        kind(figure, drawings[0 if kind is _line else place], sheet, here, moving, key, limits, place)
    if kind is _line and len(panels) > 1:
        drawings[0].legend(fontsize=8, frameon=False)
    left = f" {len(set(keys)) - len(panels)} more sets of the other axes are in index.csv." if len(set(keys)) > len(panels) else ""
    bars = how if np.isfinite(sheet.uncertainty).any() else "without uncertainty"
    return Picture(shown, svg_of(figure), f"{shown} over {' and '.join(sheet.label(m) for m in moving[:2])}; {bars}.{left}")


def _columns(table: Table) -> tuple[list[str], list[str]]:
    """Axes of numbers that move, and those of words that do."""
    values = {name: {row[name] for row in table.rows} for name in table.axes}
    words = [name for name, found in values.items() if any(isinstance(value, str | bool) for value in found)]
    return [n for n in values if len(values[n]) > 1 and n not in words], [n for n in words if len(values[n]) > 1]


def _parts(table: Table, sorts: Sequence[str]) -> list[str]:
    return [", ".join(f"{name} = {row[name]}" for name in sorts) for row in table.rows]


def _is_grid(table: Table, moving: Sequence[str]) -> bool:
    """Whether most places of the product of both axes are taken."""
    counts = [len({row[name] for row in table.rows}) for name in moving]
    places = {tuple(row[name] for name in moving) for row in table.rows}
    return len(places) > 0.3 * counts[0] * counts[1]


def _paper(panels: int) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    across = min(panels, 2)
    down = -(-panels // across)
    figure = Figure(figsize=(5.6 * across, 3.6 * down), layout="constrained")
    drawings = figure.subplots(down, across, squeeze=False).ravel().tolist()
    for spare in drawings[panels:]:
        spare.remove()
    return figure, drawings


def _line(_f: Figure, ax: Axes, sheet: Sheet, here: Mask, moving: list[str], key: str, _l: float, number: int) -> None:
    x = sheet.table.numbers(moving[0])[here]
    order = np.argsort(x)
    x, y, doubt = x[order], sheet.value[here][order], np.nan_to_num(sheet.uncertainty[here][order])
    hollow, colour = sheet.unresolved[here][order], _COLOURS[number % len(_COLOURS)]
    if len(x) > _MARKED:  # a band and no marks: the page stays small
        ax.plot(x, y, color=colour, linewidth=1, label=key or sheet.name)
        ax.fill_between(x, y - doubt, y + doubt, color=colour, alpha=0.25, linewidth=0)
    else:
        ax.errorbar(x, y, yerr=doubt, color=colour, capsize=2, linewidth=1, label=key or sheet.name)
        ax.plot(x[~hollow], y[~hollow], "o", color=colour, markersize=4)
    ax.plot(x[hollow], y[hollow], "o", markerfacecolor="white", color=colour, markersize=4)
    if is_error(sheet.name):
        ax.axhline(0, color="0.6", linewidth=0.6)
    _dress(ax, sheet, moving[0], None)
    ax.set_ylabel(sheet.words)


def _map(figure: Figure, ax: Axes, sheet: Sheet, here: Mask, moving: list[str], key: str, limit: float, _n: int) -> None:
    columns = [sheet.table.numbers(name)[here] for name in moving]
    steps = [np.unique(column) for column in columns]
    value, hidden = np.full((len(steps[1]), len(steps[0])), np.nan), np.zeros((len(steps[1]), len(steps[0])), dtype=bool)
    place = tuple(np.searchsorted(step, column) for step, column in zip(steps, columns, strict=True))
    value[place[1], place[0]], hidden[place[1], place[0]] = sheet.value[here], sheet.unresolved[here]
    edges = [
        np.exp(borders_of(np.log(step))) if sheet.logarithmic(name) else borders_of(step)
        for step, name in zip(steps, moving, strict=True)
    ]
    least = float(np.nanmin(sheet.value))
    signed = least < 0
    cmap, low = ("RdBu_r", -limit) if signed else ("viridis", least)
    drawn = ax.pcolormesh(*edges, value, cmap=cmap, vmin=low, vmax=limit)
    ax.set_facecolor("0.82")
    for row, column in zip(*np.nonzero(hidden), strict=True):
        corners = (edges[0][column], edges[0][column + 1], edges[1][row], edges[1][row + 1])
        ax.fill_between(
            corners[:2], *corners[2:], facecolor="none", edgecolor="0.2" if signed else "0.95", hatch="////", linewidth=0
        )
    figure.colorbar(drawn, ax=ax, label=sheet.words)
    _dress(ax, sheet, moving[0], moving[1])
    ax.set_title(key, fontsize=9)


def _cloud(figure: Figure, ax: Axes, sheet: Sheet, here: Mask, moving: list[str], key: str, _l: float, _n: int) -> None:
    x, colour = (sheet.table.numbers(name)[here] for name in moving[:2])
    y, hollow = sheet.value[here], sheet.unresolved[here]
    doubt = np.nan_to_num(sheet.uncertainty[here])
    ax.errorbar(x, y, yerr=doubt, fmt="none", ecolor="0.7", linewidth=0.8)
    drawn = ax.scatter(x, y, c=colour, cmap="viridis", s=22, zorder=3)
    ax.scatter(x[hollow], y[hollow], facecolor="white", edgecolor="0.3", s=22, zorder=4)
    figure.colorbar(drawn, ax=ax, label=sheet.label(moving[1]))
    _dress(ax, sheet, moving[0], None)
    ax.set_ylabel(sheet.words)
    ax.set_title(key, fontsize=9)


def _dress(ax: Axes, sheet: Sheet, across: str, up: str | None) -> None:
    ax.set_xlabel(sheet.label(across))
    if sheet.logarithmic(across):
        ax.set_xscale("log")
    if sheet.logarithmic(across) or up is not None:
        _few_ticks(ax.xaxis, sheet, across)
    if up is not None:
        ax.set_ylabel(sheet.label(up))
        if sheet.logarithmic(up):
            ax.set_yscale("log")
        _few_ticks(ax.yaxis, sheet, up)


def _few_ticks(axis: Any, sheet: Sheet, column: str) -> None:
    """Ticks at the values themselves where these are few and apart; a cell of a map is one value, drawn half-way to the next."""
    values = np.unique(sheet.table.numbers(column))
    places = np.log(values) if sheet.logarithmic(column) else values
    if len(values) <= 8 and np.all(np.diff(places) > 0.04 * np.ptp(places)):
        axis.set_ticks(values, labels=[minus(f"{value:.3g}") for value in values])
        axis.set_ticks([], minor=True)


def borders_of(middles: Array) -> Array:
    """Borders half-way between the middles (n,) of cells, and as far beyond the outer ones: (n + 1,).

    >>> borders_of(np.array([1.0, 2.0, 4.0])).tolist()
    [0.5, 1.5, 3.0, 5.0]
    """
    if len(middles) == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    inner = (middles[1:] + middles[:-1]) / 2
    return np.concatenate([[2 * middles[0] - inner[0]], inner, [2 * middles[-1] - inner[-1]]])


def svg_of(figure: Figure, hatch: float = 0.6) -> str:
    """The text of an SVG without a date, its hatches drawn with lines that wide."""
    import matplotlib as mpl

    text = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "halfplane", "font.size": 9, "hatch.linewidth": hatch}):
        literal(figure).savefig(text, format="svg", metadata={"Date": None})
    return re.sub(r"^.*?(?=<svg)", "", text.getvalue(), flags=re.DOTALL)
