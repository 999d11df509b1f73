"""What a figure of the paper consists of, said once and drawn twice: by matplotlib here, by plotly in `interactive`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from reports.drawing import STYLE, Drawing, Table, canvas

Array = NDArray[np.float64]
Dash = Literal["solid", "dash", "dot", "dashdot"]

INK, FAINT = "#1a1a1a", "#9a9a9a"
_DASHES: dict[Dash, Any] = {"solid": "-", "dash": (0, (5, 2.2)), "dot": (0, (1.2, 1.6)), "dashdot": (0, (6, 2, 1.2, 2))}


@dataclass(frozen=True, eq=False)
class Line:
    """A curve; NaN leaves a gap. Without a label it is not in the legend."""

    x: Array
    y: Array
    label: str = ""
    colour: str = INK
    dash: Dash = "solid"
    width: float = 1.4


@dataclass(frozen=True, eq=False)
class Band:
    """The area between two curves."""

    x: Array
    low: Array
    high: Array
    colour: str
    label: str = ""


@dataclass(frozen=True)
class Note:
    """A text, `shift` points away from (x, y); a dot is drawn there if wanted."""

    x: float
    y: float
    text: str
    shift: tuple[float, float] = (0.0, 0.0)
    dot: bool = False
    colour: str = INK


@dataclass(frozen=True)
class Arrow:
    """An arrow from `start` to `end`."""

    start: tuple[float, float]
    end: tuple[float, float]
    colour: str = INK


Part: TypeAlias = Line | Band | Note | Arrow


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes.

    Attributes
    ----------
    parts : drawn in this order
    x_ticks : (place, text) of each tick, automatic if empty
    equal : one scale for both axes; bare : no axes at all
    """

    x_label: str
    y_label: str
    parts: Sequence[Part]
    title: str = ""
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    x_ticks: Sequence[tuple[float, str]] = ()
    equal: bool = False
    bare: bool = False


@dataclass(frozen=True, eq=False)
class Sheet:
    """A figure: panels in rows of `columns`, one legend above them all.

    Attributes
    ----------
    size : inches; heights : relative heights of the rows; left, gaps : room as shares of the figure and of
        a panel; right : room in inches
    """

    name: str
    title: str
    caption: str
    alt: str
    panels: Sequence[Panel]
    table: Table
    columns: int = 1
    size: tuple[float, float] = (6.2, 4.2)
    heights: Sequence[float] = ()
    legend_columns: int = 4
    left: float = 0.11
    right: float = 0.15
    gaps: tuple[float, float] = (0.25, 0.3)
    handles: Sequence[Line | Band] = field(default=())


def draw(sheet: Sheet) -> Drawing:
    """The figure by matplotlib."""
    rows = -(-len(sheet.panels) // sheet.columns)
    width, height = sheet.size
    with canvas(width, height) as figure:
        grid = figure.subplots(rows, sheet.columns, squeeze=False, height_ratios=sheet.heights or None)
        entries = _entries(sheet)
        lines = -(-len(entries) // sheet.legend_columns)
        bottom = 0.48 / height if not sheet.panels[0].bare else 0.02
        top = 1 - (0.12 + 0.2 * lines + (0.2 if any(panel.title for panel in sheet.panels) else 0.06)) / height
        wide, tall = sheet.gaps
        figure.subplots_adjust(left=sheet.left, right=1 - sheet.right / width, bottom=bottom, top=top, wspace=wide, hspace=tall)
        for number, axes in enumerate(grid.flat):
            if number < len(sheet.panels):
                _panel(axes, sheet.panels[number])
            else:
                axes.set_visible(False)
        if entries:
            handles = [_handle(entry) for entry in entries]
            figure.legend(
                handles=handles,
                loc="upper left",
                bbox_to_anchor=(sheet.left, 1.0),
                ncols=sheet.legend_columns,
                borderaxespad=0.3,
                handlelength=2.4,
                columnspacing=1.4,
            )
    return Drawing(sheet.name, sheet.title, sheet.caption, sheet.alt, figure, sheet.table)


def _entries(sheet: Sheet) -> list[Line | Band]:
    """What the legend shows, each label once."""
    parts = sheet.handles or [part for panel in sheet.panels for part in panel.parts if isinstance(part, Line | Band)]
    return list({part.label: part for part in parts if part.label}.values())


def _panel(axes: Axes, panel: Panel) -> None:
    for part in panel.parts:
        _part(axes, part)
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    axes.set_title(panel.title)
    if panel.x_range:
        axes.set_xlim(*panel.x_range)
    if panel.y_range:
        axes.set_ylim(*panel.y_range)
    if panel.x_ticks:
        axes.set_xticks([place for place, _ in panel.x_ticks], [text for _, text in panel.x_ticks])
    if panel.equal:
        axes.set_aspect("equal")
    if panel.bare:
        axes.set_axis_off()


def _part(axes: Axes, part: Part) -> None:
    match part:
        case Line():
            axes.plot(part.x, part.y, color=part.colour, ls=_DASHES[part.dash], lw=part.width)
        case Band():
            axes.fill_between(part.x, part.low, part.high, color=part.colour, lw=0)
        case Note():
            if part.dot:
                axes.plot([part.x], [part.y], "o", color=part.colour, ms=3.6)
            axes.annotate(
                part.text,
                (part.x, part.y),
                xytext=part.shift,
                textcoords="offset points",
                ha="center",
                va="center",
                color=part.colour,
            )
        case Arrow():
            style = {"arrowstyle": "-|>", "color": part.colour, "lw": 1.4, "mutation_scale": 11, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", xy=part.end, xytext=part.start, arrowprops=style)


def _handle(entry: Any) -> Any:
    """What stands for a line or band in the legend."""
    if isinstance(entry, Band):
        return mpl.patches.Patch(color=entry.colour, label=entry.label, lw=0)
    return mpl.lines.Line2D([], [], color=entry.colour, ls=_DASHES[entry.dash], lw=entry.width, label=entry.label)


def png(drawing: Drawing, path: Any) -> None:
    """The figure as a PNG file, 160 points an inch."""
    with mpl.rc_context(STYLE):
        drawing.figure.savefig(path, format="png", dpi=160)
