"""The drawings of a map: errors over its two axes with lines at 1, 5 and 10 %, and over the small parameter with their laws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.maps.atlas import AXES, WORDS, Chart, place
from reports.maps.fitting import Line
from reports.maps.readings import Readings
from reports.sweep.pictures import borders_of, svg_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# Okabe and Ito's colours, told apart by most eyes; marks differ too.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a6d00", "#333333", "#56b4e9", "#e69f00")
_MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
_LEVELS = (1.0, 5.0, 10.0)
_LEAST, _MOST = 0.02, 80.0  # per cent, the colours' ends
_BAR = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 3, 4, 5, 6, 8, 10, 20, 50)
_EVEN = ("phase",)
_MARKED = tuple(digit * 10.0**power for power in range(-4, 1) for digit in (1, 2, 5))


def heat(chart: Chart, readings: Readings, figures: Sequence[str]) -> str:
    """SVG: a row for each figure, a column for each panel; |error| in per cent, hatched where it is not resolved."""
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    parts = list(readings.parts((chart.panels,)))
    paper = Figure(figsize=(1.2 + 3.4 * len(parts), 2.7 * len(figures)), layout="constrained")
    drawings = paper.subplots(len(figures), len(parts), squeeze=False, sharex=True)
    every = 100 * np.abs(np.concatenate([readings.errors(figure)[0] for figure in figures]))
    norm = LogNorm(max(_LEAST, float(np.nanmin(every))), min(_MOST, float(np.nanmax(every))))
    drawn: Any = None
    for row, figure in zip(drawings, figures, strict=True):
        for ax, (at, part) in zip(row, parts, strict=True):
            drawn = _panel(ax, chart, part, figure, norm)
            where = ", ".join(f"{AXES.get(name, name)} = {value}" for name, value in at.items())
            ax.set_title(f"{WORDS[figure]}{'; ' + where if where else ''}", fontsize=9)
    for ax in drawings[-1]:
        ax.set_xlabel(AXES.get(chart.across, chart.across))
    for ax in drawings[:, 0]:
        ax.set_ylabel(AXES.get(chart.up, chart.up))
    bar = paper.colorbar(drawn, ax=drawings, label="|error of half-plane theory|, %", shrink=0.8)
    marks = [mark for mark in _BAR if norm.vmin <= mark <= norm.vmax]  # type: ignore[operator]
    bar.set_ticks(marks, labels=[f"{mark:g}" for mark in marks])
    bar.ax.minorticks_off()
    return svg_of(paper, hatch=0.5)


def _panel(ax: Axes, chart: Chart, part: Readings, figure: str, norm: Any) -> Any:
    error, doubt = part.errors(figure)
    x, y = np.unique(part.numbers(chart.across)), np.unique(part.numbers(chart.up))
    size = np.full((len(y), len(x)), np.nan)
    hidden = np.zeros(size.shape, dtype=bool)
    place = (np.searchsorted(y, part.numbers(chart.up)), np.searchsorted(x, part.numbers(chart.across)))
    size[place], hidden[place] = 100 * np.abs(error), ~(np.abs(error) > doubt)
    # Colours are of cells, lines of the values at their middles; both axes go by factors but for angles.
    across, up = (value if name in _EVEN else np.log(value) for name, value in ((chart.across, x), (chart.up, y)))
    borders = [borders_of(middle) for middle in (across, up)]
    drawn = ax.pcolormesh(*borders, np.clip(size, norm.vmin, norm.vmax), cmap="viridis", norm=norm)
    for j, i in zip(*np.nonzero(hidden & np.isfinite(size)), strict=True):
        ax.fill_between(
            borders[0][i : i + 2], *borders[1][j : j + 2], facecolor="none", edgecolor="white", hatch="/////", linewidth=0
        )
    if min(size.shape) > 1:
        # Between points by the logarithm, as errors go by powers.
        height = np.log10(np.maximum(size, 1e-4))
        lines = ax.contour(across, up, height, levels=np.log10(_LEVELS), colors="white", linewidths=(1.0, 1.6, 2.2))
        lines.clabel(fmt=lambda level: f"{10**level:.3g} %", fontsize=8)
    ax.set_facecolor("0.8")
    _ticks(ax.xaxis, across, x)
    _ticks(ax.yaxis, up, y)
    return drawn


def _ticks(axis: Any, at: Array, values: Array) -> None:
    every = 1 if len(values) <= 6 else 2
    axis.set_ticks(at[::every], labels=[f"{float(f'{value:.3g}'):g}" for value in values[::every]])


def slopes(chart: Chart, found: Sequence[Line], figures: Sequence[str]) -> str:
    """SVG: a panel for each figure; |error| over the small parameter, hollow where unresolved, laws, the predicted slope."""
    from matplotlib.figure import Figure

    across = min(2, len(figures))
    down = -(-len(figures) // across)
    paper = Figure(figsize=(4.6 * across, 3.6 * down + 0.6), layout="constrained")
    drawings = paper.subplots(down, across, squeeze=False).ravel()
    for spare in drawings[len(figures) :]:
        spare.remove()
    for ax, figure in zip(drawings, figures, strict=False):
        chosen = [line for line in found if line.figure == figure]
        for number, line in enumerate(chosen):
            _line(ax, line, number)
        _reference(ax, chart, figure, chosen)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_title(WORDS[figure], fontsize=9)
        ends = [float(end) for line in chosen for end in (line.s.min(), line.s.max())]
        marks = [mark for mark in _MARKED if min(ends) * 0.9 <= mark <= max(ends) * 1.1]
        ax.set_xticks(marks, labels=[f"{mark:g}" for mark in marks])
        ax.set_xticks([], minor=True)
        ax.set_xlabel(chart.small)
        ax.set_ylabel("|error|, %")
    handles, labels = drawings[0].get_legend_handles_labels()
    paper.legend(handles, labels, loc="outside lower center", ncols=min(4, len(labels)), fontsize=8, frameon=False)
    return svg_of(paper, hatch=0.5)


def _line(ax: Axes, line: Line, number: int) -> None:
    colour, mark = COLOURS[number % len(COLOURS)], _MARKS[number % len(_MARKS)]
    size, doubt = 100 * np.abs(line.error), 100 * line.uncertainty
    seen = ~(size <= doubt)
    words = place(line.at, "points")
    low = np.minimum(np.nan_to_num(doubt), 0.999 * size)
    ax.errorbar(line.s, size, yerr=[low, np.nan_to_num(doubt)], fmt="none", ecolor=colour, elinewidth=0.6, alpha=0.5)
    ax.plot(line.s[seen], size[seen], mark, color=colour, markersize=4, label=words)
    ax.plot(line.s[~seen], size[~seen], mark, markerfacecolor="white", color=colour, markersize=4)
    if line.law is not None:
        s = np.geomspace(line.law.smallest, line.law.largest, 40)
        ax.plot(s, [100 * abs(line.law.value(float(here))) for here in s], color=colour, linewidth=1)


def _reference(ax: Axes, chart: Chart, figure: str, chosen: Sequence[Line]) -> None:
    if not chosen:
        return
    s = np.concatenate([line.s for line in chosen])
    size = np.concatenate([np.abs(line.error) for line in chosen])
    known = np.isfinite(size) & (size > 0)
    floor = max(100 * float(np.nanmin(size[known])) / 2, 1e-4)
    ax.set_ylim(bottom=floor)
    order = chart.order(figure)
    if order is None:
        return
    ends = np.array([s.min(), s.max()])
    level = 60 * float(np.nanmax(size[known])) * (ends / ends[1]) ** order
    others = "".join(f"; {WORDS[name]}: {power:g}" for name, power in chart.others.items())
    ax.plot(ends, level, color="0.4", linestyle=":", linewidth=1.2, label=f"slope {chart.expected:g}, predicted{others}")
