"""The figures of the paper as plotly's JSON, from the same description as the static ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.paper.plots import Arrow, Band, Line, Note, Panel, Sheet

_PIXELS = 100


def figure(sheet: Sheet) -> dict[str, Any]:
    """Traces and layout, ready for JSON: `Plotly.newPlot(div, data, layout)`."""
    traces: list[dict[str, Any]] = []
    shown: set[str] = set()
    layout: dict[str, Any] = {
        "height": round(sheet.size[1] * _PIXELS * 1.15),
        "margin": {"l": 70, "r": 60, "t": 30, "b": 50},
        "modebar": {"orientation": "v"},
        "hovermode": "closest",
        "font": {"size": 12, "color": "#1a1a1a"},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
        "annotations": [],
        "showlegend": True,
    }
    boxes = list(_boxes(sheet))
    for number, (panel, (across, up)) in enumerate(zip(sheet.panels, boxes, strict=True), start=1):
        name = "" if number == 1 else str(number)
        layout[f"xaxis{name}"] = _axis(panel, across, f"y{name}", horizontal=True)
        layout[f"yaxis{name}"] = _axis(panel, up, f"x{name}", horizontal=False)
        layout["annotations"] += list(_annotations(panel, name, across, up))
        for part in panel.parts:
            if isinstance(part, Line | Band):
                traces += _traces(part, name, shown)
        if dots := [part for part in panel.parts if isinstance(part, Note) and part.dot]:
            traces.append(_dots(dots, name))
    return {"data": traces, "layout": layout}


def _boxes(sheet: Sheet) -> Iterator[tuple[list[float], list[float]]]:
    """Domain of each panel, row by row from the top."""
    rows = -(-len(sheet.panels) // sheet.columns)
    heights = np.array(sheet.heights or [1.0] * rows)
    gap_x, gap_y = 0.06, 0.09
    wide = (1 - gap_x * (sheet.columns - 1)) / sheet.columns
    heights = heights / heights.sum() * (1 - gap_y * (rows - 1))
    for number in range(len(sheet.panels)):
        row, column = divmod(number, sheet.columns)
        top = 1 - float(heights[:row].sum()) - gap_y * row
        left = column * (wide + gap_x)
        yield [left, left + wide], [max(top - float(heights[row]), 0.0), top]


def _axis(panel: Panel, domain: list[float], anchor: str, *, horizontal: bool) -> dict[str, Any]:
    axis: dict[str, Any] = {
        "domain": domain,
        "anchor": anchor,
        "title": {"text": panel.x_label if horizontal else panel.y_label},
        "gridcolor": "#e4e4e4",
        "zeroline": False,
        "visible": not panel.bare,
    }
    limits = panel.x_range if horizontal else panel.y_range
    if limits:
        axis["range"] = list(limits)
    if horizontal and panel.x_ticks:
        axis |= {"tickvals": [place for place, _ in panel.x_ticks], "ticktext": [text for _, text in panel.x_ticks]}
    if panel.equal and not horizontal:
        axis |= {"scaleanchor": anchor}
    return axis


def _annotations(panel: Panel, name: str, across: list[float], up: list[float]) -> Iterator[dict[str, Any]]:
    """Title, notes and arrows of a panel."""
    if panel.title:
        yield {
            "text": panel.title,
            "x": across[0],
            "y": up[1],
            "xref": "paper",
            "yref": "paper",
            "xanchor": "left",
            "yanchor": "bottom",
            "showarrow": False,
        }
    here = {"xref": f"x{name}", "yref": f"y{name}"}
    for part in panel.parts:
        match part:
            case Note():
                yield here | {
                    "text": part.text.replace("\n", "<br>"),
                    "x": part.x,
                    "y": part.y,
                    "xshift": part.shift[0] * 1.3,
                    "yshift": part.shift[1] * 1.3,
                    "showarrow": False,
                    "font": {"color": part.colour},
                }
            case Arrow():
                tail = {"ax": part.start[0], "ay": part.start[1], "axref": here["xref"], "ayref": here["yref"]}
                yield here | tail | {"x": part.end[0], "y": part.end[1], "text": "", "arrowhead": 2, "arrowcolor": part.colour}


def _traces(part: Line | Band, name: str, shown: set[str]) -> list[dict[str, Any]]:
    """A curve or a band as one trace; a label stands in the legend once."""
    first = bool(part.label) and part.label not in shown
    shown.add(part.label)
    common = {
        "type": "scatter",
        "mode": "lines",
        "xaxis": f"x{name}",
        "yaxis": f"y{name}",
        "name": part.label,
        "legendgroup": part.label or None,
        "showlegend": first,
    }
    if isinstance(part, Line):
        line = {"color": part.colour, "dash": part.dash, "width": part.width * 1.2}
        return [common | {"x": _numbers(part.x), "y": _numbers(part.y), "line": line}]
    x, y = _outline(part)
    fill = {"fill": "toself", "fillcolor": part.colour, "line": {"width": 0}, "hoverinfo": "skip"}
    return [common | fill | {"x": _numbers(x), "y": _numbers(y)}]


def _outline(band: Band) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Closed outlines of the parts of a band, NaN between them."""
    known = np.isfinite(band.low) & np.isfinite(band.high)
    runs = np.split(np.arange(len(known)), np.flatnonzero(np.diff(known)) + 1)
    parts = [run for run in runs if known[run[0]]]
    gap = np.array([np.nan])
    x = [values for run in parts for values in (band.x[run], band.x[run][::-1], gap)]
    y = [values for run in parts for values in (band.low[run], band.high[run][::-1], gap)]
    return np.concatenate(x), np.concatenate(y)


def _dots(notes: Sequence[Note], name: str) -> dict[str, Any]:
    """The dots of notes as one trace."""
    return {
        "type": "scatter",
        "mode": "markers",
        "xaxis": f"x{name}",
        "yaxis": f"y{name}",
        "x": [float(f"{note.x:.6g}") for note in notes],
        "y": [float(f"{note.y:.6g}") for note in notes],
        "hovertext": [note.text for note in notes],
        "marker": {"color": [note.colour for note in notes], "size": 7},
        "showlegend": False,
    }


def _numbers(values: NDArray[np.float64] | Sequence[float]) -> list[float | None]:
    """Six digits are enough for a screen; a gap is null."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in np.asarray(values, dtype=float)]
