"""How far a sweep is, seen from outside, also while it runs; and its page: the state, a figure of
each quantity, the table.

A figure is a line with uncertainty over one axis, a map over two, points where there is no grid.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from reports.charts.plate import Axis as ChartAxis
from reports.charts.plate import (
    Band,
    Block,
    Cell,
    Curve,
    Dot,
    Key,
    Mark,
    Panel,
    Plate,
    Rule,
    colour_scale,
    labels,
    limits,
)
from reports.charts.templating import script, shades, template
from reports.studies.sweep.solving import is_error, label_of
from reports.studies.sweep.store import STATUS, Store, done
from reports.studies.sweep.study import Axis, study_of
from reports.units import number
from scenes import Scene

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# Panels of one figure; points of a line that are marked one by one; looks of lines in the style
# sheet.
_PANELS, _MARKED, _LOOKS = 6, 120, 6
_ROWS = 250  # more rows than that are in index.csv alone
_LATEST = 40  # results that the rate is taken from
_ENGINES = {"fe": "finite elements", "exact": "half-plane theory"}
_UNCERTAINTY = {
    "none": "No uncertainty was requested for these values.",
    "cheap": (
        "Uncertainty, estimated (docs/sweeps.md): from a mesh twice as coarse, theory on the"
        " polygon of the steps and, for half-planes, a far field twice as far."
    ),
    "budget": "Uncertainty and idealisation error: from the error budget of each point.",
}


def state_of(store: Store) -> Mapping[str, Any]:
    """What the store holds now, as `halfplane sweep status --json` prints it, with the table under
    "table".

    `seconds_left` is that of a sweep that goes on at the rate of the last results; None where
    nothing waits or no rate is known.
    """
    study, points = store.read_plan()
    table = store.table(points)
    failures = [
        {"point": row.number, "reason": row.reason}
        for row in table.itertuples()
        if row.status != "done"
    ]
    waiting = len(points) - len(table)
    times = []
    for address in set(table["address"]):
        with suppress(FileNotFoundError):  # set aside meanwhile
            times.append(store.path(address).stat().st_mtime)
    times = sorted(times)[-_LATEST:]
    rate = (
        (len(times) - 1) / (times[-1] - times[0])
        if len(times) > 1 and times[-1] > times[0]
        else None
    )
    counts = {"done": len(table) - len(failures), "failed": len(failures)}
    return {
        "title": study.get("title", ""),
        "points": counts | {"waiting": waiting, "total": len(points)},
        "seconds_left": waiting / rate if waiting and rate else None,
        "damaged": store.damaged(),
        "failures": failures,
        "notes": [
            {"note": note, "points": count}
            for note, count in Counter(filter(None, table["notes"])).most_common()
        ],
        "table": table,
    }


def write_page(store: Store) -> Path:
    """Write DIR/sweep.html, and DIR/index.csv that it leads to; returns the path of the page."""
    state = state_of(store)
    table = state["table"]
    study = study_of(store.read_plan()[0], str(store.folder / "sweep.json"))
    columns = [name for name in table.columns if name not in ("address", "reason", "notes")]
    name = study.scene.title or study.scene.name
    exact = "Theory is exact to rounding at the points and instants at which it is evaluated."
    program, digest = script()
    page = template("sweep.html").render(
        title=study.title or f"Sweep of {name}",
        purpose=study.purpose,
        scene=name,
        engines=" and ".join(_ENGINES[engine] for engine in study.engines),
        uncertainty=_UNCERTAINTY[study.uncertainty] if "fe" in study.engines else exact,
        state=state,
        words=[
            (_plain(figure), "{} [{}]".format(*label_of(figure, study.scene)))
            for figure in plain_figures(table, study.axes)
        ],
        pictures=draw(table, study.axes, study.scene),
        script=program,
        script_hash=digest,
        columns=columns,
        rows=[
            [_cell(value) for value in row]
            for row in table[columns][:_ROWS].itertuples(index=False)
        ],
        more=max(0, len(table) - _ROWS),
    )
    store.write_table(table)
    store.write_text(store.folder / "sweep.html", page)
    return store.folder / "sweep.html"


def _cell(value: Any) -> str:
    if not isinstance(value, float):
        return str(value)
    return "none" if math.isnan(value) else number(value)


# ------------------------------------------------------------------------------------------ figures
def _plain(name: str) -> str:
    """A name of a program as words."""
    return name.replace("_", " ")


def plain_figures(table: pd.DataFrame, axes: Sequence[Axis]) -> list[str]:
    """The figures without what is stated about them."""
    others = {"number", *STATUS, *(column for axis in axes for column in axis.columns)}
    return [
        name
        for name in table.columns
        if name not in others and not name.endswith((".uncertainty", ".idealisation"))
    ]


def draw(table: pd.DataFrame, axes: Sequence[Axis], scene: Scene) -> list[Plate]:
    """A figure of each quantity that has values, in the units of the `scene` that the sweep
    varies.
    """
    found = done(table)
    sheets = [_Sheet(name, found, axes, scene) for name in plain_figures(found, axes)]
    return [sheet.plate() for sheet in sheets if np.isfinite(sheet.value).any()]


class _Sheet:
    """One figure of a table: over one axis lines, over two that are a grid maps, else dots; each
    other combination has its own.
    """

    def __init__(self, name: str, table: pd.DataFrame, axes: Sequence[Axis], scene: Scene) -> None:
        self.name, self.table = name, table
        self.axes = {column: axis for axis in axes for column in axis.columns}
        self.shown = f"{name}.idealisation" if f"{name}.idealisation" in table else name
        blank = table[name] * np.nan
        self.value, self.uncertainty = (
            table.get(key, blank).to_numpy(float) for key in (self.shown, f"{name}.uncertainty")
        )
        margin = np.nan_to_num(self.uncertainty)
        self.low, self.high = self.value - margin, self.value + margin
        # An error that is not larger than its uncertainty.
        self.unresolved = (np.abs(self.value) <= self.uncertainty) & is_error(name)
        self.words = f"{_plain(name)}  [{label_of(name, scene)[1]}]"

    def plate(self) -> Plate:
        """The figure with its caption and its numbers."""
        moves = [name for name in self.axes if self.table[name].nunique() > 1]
        sorts = [
            name
            for name in moves
            if any(isinstance(value, str | bool) for value in self.table[name].tolist())
        ]
        moving = [name for name in moves if name not in sorts]
        stem, title = self.shown.replace(".", "-"), _plain(self.shown)
        csv = {
            **{column: self.numbers(column) for column in moving},
            self.shown: self.value,
            "uncertainty": self.uncertainty,
        }
        if not moving:
            text = (
                f"{number(float(self.value[0]))}: the sweep has one point on every axis of numbers"
            )
            return Plate(stem, title, text, text, (), csv)
        keys = np.array(
            [
                ", ".join(f"{name} = {row[name]}" for name in sorts)
                for row in self.table[sorts].to_dict("records")
            ]
        )
        parts = np.unique(keys).tolist()
        masks = [(part, keys == part) for part in parts[:_PANELS]]
        legend: tuple[Key, ...] = ()
        panels: list[Panel | Cell]
        places = len(self.table[moving].drop_duplicates()) / np.prod(
            [self.table[name].nunique() for name in moving]
        )
        if len(moving) == 1:
            panels, how = (
                [self.line(stem, masks, moving[0])],
                "bars are its uncertainty; hollow: not resolved",
            )
            legend = tuple(
                Key(f"line-{k}", _plain(part)) for k, (part, _) in enumerate(masks) if part
            )
        elif len(moving) == 2 and places > 0.3:
            how = "hatched: unresolved, the error is less than its uncertainty; grey: no result"
            panels = [
                self.map(f"{stem}-{k}", here, moving, part) for k, (part, here) in enumerate(masks)
            ]
        else:
            how = "hollow: unresolved; colour: the second axis"
            panels = [
                self.cloud(f"{stem}-{k}", here, moving, part)
                for k, (part, here) in enumerate(masks)
            ]
        left = (
            f" {len(parts) - _PANELS} more sets of the other axes are in index.csv."
            if len(parts) > _PANELS
            else ""
        )
        bars = how if np.isfinite(self.uncertainty).any() else "without uncertainty"
        caption = f"Over {' and '.join(self.label(name) for name in moving[:2])}; {bars}.{left}"
        return Plate(
            stem,
            title,
            caption,
            f"{title}. {caption}",
            tuple(panels),
            csv,
            legend,
            min(2, len(panels)),
        )

    def numbers(self, column: str) -> Array:
        """A coordinate (n,)."""
        return self.table[column].to_numpy(float)

    def title(self, row: int) -> str:
        """What a reader sees of a value."""
        return f"{_plain(self.name)} = {number(float(self.value[row]))}" + (
            ", not resolved" if self.unresolved[row] else ""
        )

    def label(self, column: str) -> str:
        """Words of an axis."""
        axis = self.axes[column]
        own = axis.label or axis.name if column == axis.name else ""
        return _plain(own or column) + (f" [{axis.unit}]" if own and axis.unit else "")

    def axis(self, column: str, *, cells: bool = False) -> ChartAxis:
        """An axis of numbers; its ticks stand at the values themselves where these are few and
        apart.

        With `cells` it goes half a step beyond the outer values: a cell of a map is one value.
        """
        log = self.axes[column].by_factors
        values = np.unique(self.numbers(column))
        at = np.log(values) if log else values
        apart = (log or cells) and len(values) <= 8 and np.all(np.diff(at) > 0.04 * np.ptp(at))
        ends = np.array(limits(at, margin=0.05))
        low, high = (
            cell_borders(values, log=log)[[0, -1]] if cells else np.exp(ends) if log else ends
        ).tolist()
        own = (
            tuple(
                zip(
                    values.tolist(),
                    labels([float(f"{value:.3g}") for value in values]),
                    strict=True,
                )
            )
            if apart
            else ()
        )
        return ChartAxis(low, high, self.label(column), log, ticks=own)

    def line(self, name: str, masks: Sequence[tuple[str, Mask]], moving: str) -> Panel:
        """Curves over one axis: dots with bars; of many points a band, and dots where unresolved,
        so that the page stays small.
        """
        drawn: list[Mark] = [Rule(0.0, "zero")] if is_error(self.name) else []
        places = self.numbers(moving)
        for k, (part, here) in enumerate(masks):
            rows, look = np.flatnonzero(here)[np.argsort(places[here])], f"line-{k % _LOOKS}"
            x, y, low, high = (column[rows] for column in (places, self.value, self.low, self.high))
            drawn.append(Curve(x, y, look, _plain(part) or _plain(self.name)))
            if many := len(rows) > _MARKED:
                drawn.insert(0, Band(x, low, high, f"p{k % _LOOKS} pale"))
            else:
                drawn.append(bars(x, low, high, look))
            for a, b, hollow in zip(x.tolist(), y.tolist(), self.unresolved[rows], strict=True):
                if hollow or not many:
                    drawn.append(
                        Dot(a, b, f"{look} hollow" if hollow else f"{look} p{k % _LOOKS}", 3.0)
                    )
        up = ChartAxis(*limits(self.low, self.high, zero=is_error(self.name)), self.words)
        return Panel(
            name,
            self.axis(moving),
            up,
            drawn,
            f"{_plain(self.name)} over {self.label(moving)}",
            560.0,
            340.0,
        )

    def map(self, name: str, here: Mask, moving: list[str], part: str) -> Cell:
        """Coloured cells over two axes."""
        axes = self.axis(moving[0], cells=True), self.axis(moving[1], cells=True)
        least, most = float(np.nanmin(self.value)), float(np.nanmax(np.abs(self.value)))
        low, high, colours = (
            (-most, most, "RdBu_r")
            if least < 0
            else (least, float(np.nanmax(self.value)), "viridis")
        )
        share = np.where(here, (self.value - low) / ((high - low) or 1.0), np.nan)
        names = [self.title(row) for row in range(len(share))]
        drawn = heat_map(
            axes,
            (self.numbers(moving[0]), self.numbers(moving[1])),
            share,
            names,
            self.unresolved,
            colours,
        )
        panel = Panel(
            name, *axes, drawn, f"Map of {_plain(self.name)}, {part}", 480.0, 360.0, _plain(part)
        )
        return Cell((panel, colour_scale(f"{name}-colours", low, high, self.words, colours)), None)

    def cloud(self, name: str, here: Mask, moving: list[str], part: str) -> Cell:
        """Dots over the first axis, coloured by the second."""
        (x, second), (across, other) = map(self.numbers, moving[:2]), map(self.axis, moving[:2])
        ends = np.array([other.low, other.high])
        share = (
            np.interp(np.log(second), np.log(ends), [0.0, 1.0])
            if other.log
            else np.interp(second, ends, [0.0, 1.0])
        )
        drawn: list[Mark] = [bars(x[here], self.low[here], self.high[here], "faint")]
        for row in np.flatnonzero(here & np.isfinite(self.value)).tolist():
            look = "faint hollow" if self.unresolved[row] else ""
            fill = "" if look else shades([share[row]])[0]
            drawn.append(
                Dot(float(x[row]), float(self.value[row]), look, 3.6, self.title(row), fill=fill)
            )
        up = ChartAxis(*limits(self.low, self.high), self.words)
        panel = Panel(
            name,
            across,
            up,
            drawn,
            f"{_plain(self.name)} over {across.words}, {part}",
            480.0,
            340.0,
            _plain(part),
        )
        return Cell(
            (
                panel,
                colour_scale(f"{name}-colours", other.low, other.high, other.words, log=other.log),
            ),
            None,
        )


def bars(x: Array, low: Array, high: Array, look: str) -> Curve:
    """Upright lines from `low` to `high` at each x."""
    gap = np.full(len(x), np.nan)
    return Curve(
        np.column_stack([x, x, gap]).ravel(),
        np.column_stack([low, high, gap]).ravel(),
        f"{look} bar-line",
    )


def heat_map(
    axes: tuple[ChartAxis, ChartAxis],
    places: tuple[Array, Array],
    share: Array,
    names: Sequence[str],
    unresolved: Mask,
    colours: str = "viridis",
) -> list[Mark]:
    """Cells around places (n,) on both axes, coloured by `share` (n,) of the scale; hatched where
    unresolved, grey where NaN.
    """
    drawn: list[Mark] = [
        Block((axes[0].low, axes[0].high), (axes[1].low, axes[1].high), "no-value")
    ]
    ends = []
    for axis, place in zip(axes, places, strict=True):
        steps, at = np.unique(place, return_inverse=True)
        borders = cell_borders(steps, log=axis.log)
        ends.append(list(zip(borders[at].tolist(), borders[at + 1].tolist(), strict=True)))
    for row in np.flatnonzero(np.isfinite(share)).tolist():
        fill = shades([share[row]], colours)[0]
        drawn.append(Block(ends[0][row], ends[1][row], "", names[row], fill, bool(unresolved[row])))
    return drawn


def cell_borders(middles: Array, *, log: bool = False) -> Array:
    """Borders half-way (by factors with `log`) between the middles (n,) of cells, and as far beyond
    the outer ones: (n + 1,).

    >>> cell_borders(np.array([1.0, 2.0, 4.0])).tolist()
    [0.5, 1.5, 3.0, 5.0]
    """
    at = np.log(middles) if log else middles
    inner = (at[1:] + at[:-1]) / 2
    # of one cell: a width of 1
    first, last = (inner[0], inner[-1]) if len(inner) else (at[0] + 0.5, at[0] - 0.5)
    borders = np.concatenate([[2 * at[0] - first], inner, [2 * at[-1] - last]])
    return np.exp(borders) if log else borders
