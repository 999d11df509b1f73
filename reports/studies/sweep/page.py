"""How far a sweep is, seen from outside, also while it runs; and its page: the state, a figure of
each quantity, the table.

A figure is a line with uncertainty over one axis, a map over two, points where there is no grid.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Hashable, Iterator, Mapping, Sequence
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
    Note,
    Panel,
    Plate,
    Rule,
    colour_scale,
    labels,
    limits,
)
from reports.charts.templating import script, shades, template
from reports.comparison.words import with_uncertainty
from reports.studies.sweep.solving import is_error, label_of, shown_factor
from reports.studies.sweep.store import STATUS, Store, rows_with_figures
from reports.studies.sweep.study import Axis, study_of
from reports.units import number, significant
from scenes import Scene
from scenes.array_types import Array

Mask = NDArray[np.bool_]
_PANELS = 6  # of one figure
_MARKED = 120  # points of a line that are marked one by one
_LOOKS = 6  # of lines in the style sheet
_ROWS = 250  # more rows than that are in index.csv alone
_FILLED = 0.3  # share of a grid that has points, from which on it is a map
_NUMBERED = 64  # cells of a map that have their numbers
_WORDS_OF_LINE = 0.055  # height of a line of words over that of a panel
_FLAT = 1e-9  # spread of values over their size that is round-off error
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
    """What the store of a sweep holds now, as `halfplane sweep status --json` prints it, with the
    table of results under "table".

    `seconds_left` is that of a sweep that resumes at the rate of the last results; None where no
    point waits or no rate is known.
    """
    study, points = store.read_plan()
    table = store.table(points)
    failures = [
        {"point": row.number, "reason": row.reason}
        for row in table.itertuples()
        if row.status != "done"
    ]
    n_waiting = len(points) - len(table)
    times_of_results = []
    for address in set(table["address"]):
        with suppress(FileNotFoundError):  # set aside meanwhile
            times_of_results.append(store.path(address).stat().st_mtime)
    rate = _rate(sorted(times_of_results)[-_LATEST:])
    counts = {"done": len(table) - len(failures), "failed": len(failures)}
    return {
        "title": study.get("title", ""),
        "points": counts | {"waiting": n_waiting, "total": len(points)},
        "seconds_left": n_waiting / rate if n_waiting and rate else None,
        "damaged": store.damaged(),
        "failures": failures,
        "notes": [
            {"note": note, "points": count}
            for note, count in Counter(filter(None, table["notes"])).most_common()
        ],
        "table": table,
    }


def _rate(times: Sequence[float]) -> float | None:
    """Results in a second, of times in their order; None where they give none."""
    if len(times) < 2 or times[-1] <= times[0]:
        return None
    return (len(times) - 1) / (times[-1] - times[0])


def write_page(store: Store) -> Path:
    """Write the page of a sweep to DIR/sweep.html, and the table DIR/index.csv that it links to,
    DIR being the folder of the `store` of results. Returns the path of the page.
    """
    state = state_of(store)
    table = state["table"]
    study = study_of(store.read_plan()[0], str(store.folder / "sweep.json"))
    name = study.scene.title or study.scene.name
    uncertainty = "Theory is exact to rounding at the points and instants at which it is evaluated."
    if "fe" in study.engines:
        uncertainty = _UNCERTAINTY[study.uncertainty]
    heads, rows = table_in_words(table[:_ROWS], study.axes, study.scene)
    pictures = draw(table, study.axes, study.scene)
    program, script_digest = script()
    page = template("sweep.html").render(
        title=study.title or f"Sweep of {name}",
        purpose=study.purpose,
        scene=name,
        engines=" and ".join(_ENGINES[engine] for engine in study.engines),
        uncertainty=uncertainty,
        state=state,
        pictures=pictures,
        wide=any(plate.columns > 1 for plate in pictures),
        script=program,
        script_hash=script_digest,
        columns=heads,
        rows=rows,
        more=max(0, len(table) - _ROWS),
    )
    store.write_table(table)
    store.write_text(store.folder / "sweep.html", page)
    return store.folder / "sweep.html"


def table_in_words(
    table: pd.DataFrame, axes: Sequence[Axis], scene: Scene, *, in_short: bool = False
) -> tuple[list[str], list[list[str]]]:
    """A sweep as a table of texts: heads with units, and a row for each point with its coordinates,
    the values computed there with their uncertainties, and how it went.

    Parameters
    ----------
    table
        a row for each point
    axes, scene
        of the study
    in_short
        values by their names in the study, and nothing on how it went
    """
    columns = [column for axis in axes for column in axis.columns]
    figures = plain_figures(table, axes)
    heads = ["point", *(_label_of_axis(axis, column) for axis in axes for column in axis.columns)]
    for figure in figures:
        figure_in_words, unit = label_of(figure, scene)
        heads.append(f"{figure if in_short else figure_in_words} [{unit}]")
    if not in_short:
        heads += ["status", "seconds"]
    rows = []
    for record in table.to_dict("records"):
        cells = [str(record["number"])]
        cells += [_cell(record[column]) for column in columns]
        cells += [_figure_cell(record, figure) for figure in figures]
        if not in_short:
            cells += [str(record["status"]), f"{record['seconds']:.2g}"]
        rows.append(cells)
    return heads, rows


def _figure_cell(record: Mapping[Hashable, Any], figure: str) -> str:
    """A value with its uncertainty; errors in per cent."""
    factor = shown_factor(figure)
    value = factor * float(record[figure])
    if math.isnan(value):
        return "none"
    uncertainty = factor * float(record.get(f"{figure}.uncertainty", math.nan))
    if math.isnan(uncertainty):
        return significant(value, 4)
    return with_uncertainty(value, uncertainty)


def _cell(value: Any) -> str:
    """A coordinate as text."""
    return number(value) if isinstance(value, float) else str(value)


def _label_of_axis(axis: Axis, column: str) -> str:
    """Words of an axis with its unit; of rows of values the name of the column."""
    if column != axis.name:
        return _plain(column)
    unit = f" [{axis.unit}]" if axis.unit else ""
    return f"{_plain(axis.label or axis.name)}{unit}"


# ------------------------------------------------------------------------------------------ figures
def _plain(name: str) -> str:
    """A name of a program as words."""
    return name.replace("_", " ")


def plain_figures(table: pd.DataFrame, axes: Sequence[Axis]) -> list[str]:
    """The figures without what is stated about them."""
    of_axes = {column for axis in axes for column in axis.columns}
    no_figures = {"number", *STATUS, *of_axes}
    return [
        name
        for name in table.columns
        if name not in no_figures and not name.endswith((".uncertainty", ".idealisation"))
    ]


def draw(table: pd.DataFrame, axes: Sequence[Axis], scene: Scene) -> list[Plate]:
    """A figure of each quantity that has values, in the units of the `scene` that the sweep
    varies.
    """
    results = rows_with_figures(table)
    sheets = [_Sheet(name, results, axes, scene) for name in plain_figures(results, axes)]
    return [sheet.plate() for sheet in sheets if np.isfinite(sheet.value).any()]


class _Sheet:
    """One figure of a table. Over one axis lines with bars; over two a map with its numbers where
    they are a grid, and lines along each of the two; else dots. Each combination of the other axes
    has its own.
    """

    def __init__(self, name: str, table: pd.DataFrame, axes: Sequence[Axis], scene: Scene) -> None:
        """Take the values of one quantity of a sweep (`name`, such as "fe.p0") at all points from
        its table, with their uncertainties, in the unit that is shown, and the words of the figure.

        Where the table has the idealisation error of that quantity, which is its difference from
        theory without the errors of mesh and steps, that is drawn, with the same uncertainty.
        `axes` are those of the sweep.
        """
        self.name = name
        self.table = table
        self.axes = {column: axis for axis in axes for column in axis.columns}
        self.drawn_column = name
        if f"{name}.idealisation" in table:
            self.drawn_column = f"{name}.idealisation"
        factor = shown_factor(name)
        self.value = factor * table[self.drawn_column].to_numpy(float)
        self.uncertainty = np.full(len(table), np.nan)
        if f"{name}.uncertainty" in table:
            self.uncertainty = factor * table[f"{name}.uncertainty"].to_numpy(float)
        margin = np.nan_to_num(self.uncertainty)
        self.low = self.value - margin
        self.high = self.value + margin
        # An error that is not larger than its uncertainty.
        self.unresolved = (np.abs(self.value) <= self.uncertainty) & is_error(name)
        self.title_words, self.unit = label_of(name, scene)
        if self.drawn_column != name:
            self.title_words += ", idealisation error"
        label = "finite elements/theory − 1" if is_error(name) else _plain(name)
        self.words = f"{label}  [{self.unit}]"

    def plate(self) -> Plate:
        """The figure of one quantity of a sweep with caption and numbers: lines over one axis, a
        map over two that form a grid, else dots. Each combination of the other axes, such as two
        kinds of bodies, has a curve or panel of its own.
        """
        varied_axes = [name for name in self.axes if self.table[name].nunique() > 1]
        # axes of words, such as kinds of bodies, and axes of numbers
        word_axes = [name for name in varied_axes if self._has_words(name)]
        number_axes = [name for name in varied_axes if name not in word_axes]
        stem = self.drawn_column.replace(".", "-")
        title = self.title_words
        csv_columns = {
            **{column: self.numbers(column) for column in number_axes},
            f"{self.drawn_column} [{self.unit}]": self.value,
            "uncertainty": self.uncertainty,
        }
        if not number_axes:
            text = (
                f"{number(float(self.value[0]))}: the sweep has one point on every axis of numbers"
            )
            return Plate(stem, title, text, text, (), csv_columns)
        combination_of_rows = self._values_in_words(word_axes)
        combinations = np.unique(combination_of_rows).tolist()
        masks = [
            (combination, combination_of_rows == combination)
            for combination in combinations[:_PANELS]
        ]
        panels, legend, signs_in_words = self._panels(stem, masks, number_axes)
        if not np.isfinite(self.uncertainty).any():
            signs_in_words = "without uncertainty"
        axes_in_words = " and ".join(self.label(name) for name in number_axes[:2])
        caption = f"Over {axes_in_words}; {signs_in_words}."
        if len(combinations) > _PANELS:
            caption += (
                f" {len(combinations) - _PANELS} more sets of the other axes are in index.csv."
            )
        return Plate(
            stem,
            title,
            caption,
            f"{title}. {caption}",
            tuple(panels),
            csv_columns,
            legend,
            min(3, len(panels)),
        )

    def _panels(
        self, stem: str, masks: Sequence[tuple[str, Mask]], number_axes: list[str]
    ) -> tuple[list[Panel | Cell], tuple[Key, ...], str]:
        """The panels of the figure of one quantity of a sweep, its legend, and what its signs mean,
        in words.

        Parameters
        ----------
        stem
            beginning of the names of panels
        masks
            each combination of the axes of words, in words, with its points (n,)
        number_axes
            names of the axes of numbers, at least one
        """
        panels: list[Panel | Cell]
        if len(number_axes) == 1:
            panels = [self.line(stem, masks, number_axes[0])]
            legend = tuple(
                Key(f"line-{index}", _plain(combination))
                for index, (combination, _) in enumerate(masks)
                if combination
            )
            return panels, legend, "bars are its uncertainty; hollow: not resolved"
        if len(number_axes) == 2 and self._filled_share(number_axes) > _FILLED:
            panels = [
                self.map(f"{stem}-{index}", mask, number_axes, combination)
                for index, (combination, mask) in enumerate(masks)
            ]
            for index, (_, mask) in enumerate(masks):
                panels += self.along_each(f"{stem}-{index}", mask, number_axes)
            signs_in_words = (
                "hatched, hollow: not resolved, the error is less than its uncertainty; grey: no"
                " result; bars are the uncertainty"
            )
            return panels, (), signs_in_words
        panels = [
            self.cloud(f"{stem}-{index}", mask, number_axes, combination)
            for index, (combination, mask) in enumerate(masks)
        ]
        return panels, (), "hollow: not resolved; colour: the second axis"

    def along_each(self, name: str, mask: Mask, columns: Sequence[str]) -> Iterator[Panel]:
        """Two panels of lines for a map over two axes: one along each axis, with a line for each
        value of the other axis, which is written at its end. Of many values the first, the last and
        some between are drawn.

        Parameters
        ----------
        name
            beginning of the names of the two panels
        mask
            (n,) points of the sweep that belong to the map
        columns
            names of the two axes
        """
        for index, (column, other_column) in enumerate((columns, columns[::-1])):
            coordinate = self.numbers(other_column)
            values = np.unique(coordinate[mask])
            n_lines = min(len(values), _LOOKS)
            chosen = np.unique(np.linspace(0, len(values) - 1, n_lines).round()).astype(int)
            lines = [
                (f"{_plain(other_column)} = {number(value)}", mask & (coordinate == value))
                for value in values[chosen].tolist()
            ]
            yield self.line(f"{name}-along-{index}", lines, column, named=True)

    def _has_words(self, column: str) -> bool:
        """Whether a coordinate has values that are no numbers."""
        return any(isinstance(value, str | bool) for value in self.table[column].tolist())

    def _values_in_words(self, columns: Sequence[str]) -> NDArray[np.str_]:
        """(n,) the values that a point has on these axes, as text."""
        texts = []
        for row in self.table[list(columns)].to_dict("records"):
            values = [f"{name} = {row[name]}" for name in columns]
            texts.append(", ".join(values))
        return np.array(texts)

    def _filled_share(self, columns: list[str]) -> float:
        """How much of the grid of all values on these axes has a point."""
        cells = np.prod([self.table[name].nunique() for name in columns])
        return float(len(self.table[columns].drop_duplicates()) / cells)

    def numbers(self, column: str) -> Array:
        """A coordinate (n,)."""
        return self.table[column].to_numpy(float)

    def title(self, row: int) -> str:
        """The text that a pointer shows at the value of a row: quantity, value, unit and remark."""
        remark = ", not resolved" if self.unresolved[row] else ""
        return f"{self.title_words}: {number(float(self.value[row]))} {self.unit}{remark}"

    def label(self, column: str) -> str:
        """Words of an axis."""
        return _label_of_axis(self.axes[column], column)

    def axis(self, column: str, *, cells: bool = False) -> ChartAxis:
        """The axis of a chart for an axis of a sweep (`column`); its ticks stand at the values
        themselves where these are few and apart.

        With `cells` it goes half a step beyond the outer values: a cell of a map is one value.
        """
        log = self.axes[column].by_factors
        values = np.unique(self.numbers(column))
        places = np.log(values) if log else values
        if cells:
            ends = cell_borders(values, log=log)[[0, -1]]
        else:
            ends = np.array(limits(places, margin=0.05))
            if log:
                ends = np.exp(ends)
        least_value, largest_value = ends.tolist()
        ticks: tuple[tuple[float, str], ...] = ()
        are_few = len(values) <= 8 and np.all(np.diff(places) > 0.04 * np.ptp(places))
        if (log or cells) and are_few:
            texts = labels([float(f"{value:.3g}") for value in values])
            ticks = tuple(zip(values.tolist(), texts, strict=True))
        return ChartAxis(least_value, largest_value, self.label(column), log, ticks=ticks)

    def line(
        self, name: str, masks: Sequence[tuple[str, Mask]], column: str, *, named: bool = False
    ) -> Panel:
        """A panel of curves of one quantity of a sweep over one axis.

        Points are dots with bars for their uncertainty; a curve of many points has a band instead,
        and dots where the value is not resolved, so that the page stays small.

        Parameters
        ----------
        masks
            for each curve its label, and which points of the sweep it has, (n,)
        column
            name of the axis
        named
            whether each curve has its label at its end
        """
        low_value, high_value = limits(self.low, self.high)
        if named:  # room for the words
            high_value += _WORDS_OF_LINE * len(masks) * (high_value - low_value)
        drawn_marks: list[Mark] = [Rule(0.0, "zero")] if low_value < 0 < high_value else []
        places = self.numbers(column)
        x_axis = self.axis(column)
        for curve_number, (curve_in_words, mask) in enumerate(masks):
            rows = np.flatnonzero(mask)[np.argsort(places[mask])]
            look = f"line-{curve_number % _LOOKS}"
            fill = f"p{curve_number % _LOOKS}"
            x = places[rows]
            y = self.value[rows]
            drawn_marks.append(Curve(x, y, look, curve_in_words or self.title_words))
            if named:
                shift_down = 14.0 + 15.0 * curve_number
                drawn_marks.append(
                    Note(
                        x_axis.high,
                        high_value,
                        curve_in_words,
                        f"tick over t{curve_number}",
                        "end",
                        (-4.0, shift_down),
                    )
                )
            is_long = len(rows) > _MARKED
            if is_long:
                drawn_marks.insert(0, Band(x, self.low[rows], self.high[rows], f"{fill} pale"))
            else:
                drawn_marks.append(bars(x, self.low[rows], self.high[rows], look))
            for dot_x, dot_y, is_unresolved in zip(
                x.tolist(), y.tolist(), self.unresolved[rows], strict=True
            ):
                if is_unresolved:
                    drawn_marks.append(Dot(dot_x, dot_y, f"{look} hollow", 3.0))
                elif not is_long:
                    drawn_marks.append(Dot(dot_x, dot_y, f"{look} {fill}", 3.0))
        return Panel(
            name,
            x_axis,
            ChartAxis(low_value, high_value, self.words),
            drawn_marks,
            f"{self.title_words} over {self.label(column)}",
            480.0,
            340.0,
        )

    def map(self, name: str, mask: Mask, columns: list[str], combination: str) -> Cell:
        """A map of one quantity of a sweep over two axes (`columns`): a panel with a coloured
        rectangle for each point of `mask`, and the scale of colours beneath. `combination` says in
        words which values of the other axes it is for.
        """
        x_axis, y_axis = (self.axis(column, cells=True) for column in columns)
        least_value = float(np.nanmin(self.value))
        largest_value = float(np.nanmax(self.value))
        # What differs by no more than it is uncertain, or by round-off, has one colour.
        is_flat = largest_value - least_value <= _FLAT * max(abs(least_value), abs(largest_value))
        range_of_values = math.inf if is_flat else largest_value - least_value
        share_of_range = np.where(mask, (self.value - least_value) / range_of_values, np.nan)
        names = [self.title(row) for row in range(len(share_of_range))]
        x, y = map(self.numbers, columns)
        drawn_marks = heat_map((x_axis, y_axis), (x, y), share_of_range, names, self.unresolved)
        rows_of_cells = np.flatnonzero(mask & np.isfinite(self.value)).tolist()
        if len(rows_of_cells) <= _NUMBERED:
            drawn_marks += [
                Note(x[row], y[row], significant(self.value[row], 3), "tick over", "middle", (0, 4))
                for row in rows_of_cells
            ]
        alt = f"Map of {self.title_words}, {combination}"
        panel = Panel(name, x_axis, y_axis, drawn_marks, alt, 480.0, 360.0, _plain(combination))
        if is_flat:
            return Cell((panel,), None)
        scale = colour_scale(f"{name}-colours", (least_value, largest_value), self.words)
        return Cell((panel, scale), None)

    def cloud(self, name: str, mask: Mask, columns: list[str], combination: str) -> Cell:
        """A panel with a dot for each point of `mask`: the value of one quantity of a sweep over
        the first of `columns`, coloured by the second, with the scale of colours beneath.
        `combination` says in words which values of the other axes it is for.
        """
        x, coloured_values = map(self.numbers, columns[:2])
        x_axis, colour_axis = map(self.axis, columns[:2])
        ends = np.array([colour_axis.low, colour_axis.high])
        if colour_axis.log:
            share_of_scale = np.interp(np.log(coloured_values), np.log(ends), [0.0, 1.0])
        else:
            share_of_scale = np.interp(coloured_values, ends, [0.0, 1.0])
        drawn_marks: list[Mark] = [bars(x[mask], self.low[mask], self.high[mask], "faint")]
        for row in np.flatnonzero(mask & np.isfinite(self.value)).tolist():
            look = "faint hollow" if self.unresolved[row] else ""
            fill = "" if look else shades([share_of_scale[row]])[0]
            drawn_marks.append(
                Dot(float(x[row]), float(self.value[row]), look, 3.6, self.title(row), fill=fill)
            )
        y_axis = ChartAxis(*limits(self.low, self.high), self.words)
        panel = Panel(
            name,
            x_axis,
            y_axis,
            drawn_marks,
            f"{self.title_words} over {x_axis.words}, {combination}",
            480.0,
            340.0,
            _plain(combination),
        )
        scale = colour_scale(
            f"{name}-colours",
            (colour_axis.low, colour_axis.high),
            colour_axis.words,
            log=colour_axis.log,
        )
        return Cell((panel, scale), None)


def bars(x: Array, lower_ends: Array, upper_ends: Array, look: str) -> Curve:
    """Upright lines from `lower_ends` to `upper_ends` at each x."""
    gap = np.full(len(x), np.nan)
    return Curve(
        np.column_stack([x, x, gap]).ravel(),
        np.column_stack([lower_ends, upper_ends, gap]).ravel(),
        f"{look} bar-line",
    )


def heat_map(
    axes: tuple[ChartAxis, ChartAxis],
    places: tuple[Array, Array],
    share: Array,
    names: Sequence[str],
    is_unresolved: Mask,
) -> list[Mark]:
    """What is drawn for a map over two axes: a coloured rectangle around each of n places, on a
    grey ground.

    Parameters
    ----------
    axes
        of the panel, across and up
    places
        (n,) coordinates on each of the two axes
    share
        (n,) value as a share of the scale of colours; where it is NaN the ground is seen
    names
        label of each rectangle
    is_unresolved
        (n,) whether it is hatched
    """
    x_axis, y_axis = axes
    marks: list[Mark] = [Block((x_axis.low, x_axis.high), (y_axis.low, y_axis.high), "no-value")]
    cells_across = _cells_of(x_axis, places[0])
    cells_up = _cells_of(y_axis, places[1])
    for row in np.flatnonzero(np.isfinite(share)).tolist():
        fill = shades([share[row]])[0]
        is_hatched = bool(is_unresolved[row])
        marks.append(Block(cells_across[row], cells_up[row], "", names[row], fill, is_hatched))
    return marks


def _cells_of(axis: ChartAxis, places: Array) -> list[tuple[float, float]]:
    """Both borders of the cell that each place (n,) stands in."""
    middles, cells = np.unique(places, return_inverse=True)
    borders = cell_borders(middles, log=axis.log)
    return list(zip(borders[cells].tolist(), borders[cells + 1].tolist(), strict=True))


def cell_borders(middles: Array, *, log: bool = False) -> Array:
    """Borders half-way (by factors with `log`) between the middles (n,) of cells, and as far beyond
    the outer ones, (n + 1,).

    >>> cell_borders(np.array([1.0, 2.0, 4.0])).tolist()
    [0.5, 1.5, 3.0, 5.0]
    """
    places = np.log(middles) if log else middles
    inner_borders = (places[1:] + places[:-1]) / 2
    if len(inner_borders):
        outer_borders = [2 * places[0] - inner_borders[0], 2 * places[-1] - inner_borders[-1]]
    else:  # of one cell: a width of 1
        outer_borders = [places[0] - 0.5, places[0] + 0.5]
    borders = np.concatenate([outer_borders[:1], inner_borders, outer_borders[1:]])
    return np.exp(borders) if log else borders
