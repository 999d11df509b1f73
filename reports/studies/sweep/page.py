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
    axis_limits,
    colour_scale,
    tick_labels,
)
from reports.charts.templating import colours_of, script, template
from reports.comparison.words import with_uncertainty
from reports.studies.sweep.solving import display_factor, is_error, label_of
from reports.studies.sweep.store import STATUS_COLUMNS, Store, solved_rows_of
from reports.studies.sweep.study import Axis, study_of
from reports.units import number, significant
from scenes import Scene
from scenes.array_types import Array

Mask = NDArray[np.bool_]
_MOST_PANELS = 6  # of one figure
_MOST_DOTS = 120  # points of a line that are marked one by one
_N_LOOKS = 6  # of lines in the style sheet
_MOST_ROWS = 250  # more rows than that are in index.csv alone
_LEAST_FILLED_SHARE = 0.3  # share of a grid that has points, from which on it is a map
_MOST_NUMBERED_CELLS = 64  # cells of a map that have their numbers
_WORD_HEIGHT = 0.055  # height of a line of words over that of a panel
# Least range of an axis of values over their largest size: less is round-off or noise of a mesh,
# and numbers with six digits beside the axis would be equal.
_LEAST_RANGE_OF_VALUES = 1e-3
_ROUNDOFF_SPREAD = 1e-9  # spread of values over their size that is round-off error
_N_LATEST_RESULTS = 40  # results that the rate is taken from
_ENGINES = {"fe": "finite elements", "exact": "half-plane theory"}
_UNCERTAINTY = {
    "none": "No uncertainty was requested for these values.",
    "cheap": (
        "Uncertainty, estimated (docs/sweeps.md): from a mesh twice as coarse, theory on the"
        " polygon of the steps and, for half-planes, a far field twice as far."
    ),
    "budget": "Uncertainty and idealisation error: from the error budget of each point.",
}


def sweep_state(store: Store) -> Mapping[str, Any]:
    """How far a sweep is, by what its store holds now. By name: title of the study, numbers of
    points done, failed, waiting and in total, failures and notes, damaged files that were set
    aside, and the "table" of results.

    "seconds_left" is the time to the end at the rate of the last results; None where no point waits
    or no rate is known.
    """
    study, points = store.read_plan()  # keys of the study, and all its points
    table = store.table(points)  # a row for each point that has a result
    failures = [
        {"point": row.number, "reason": row.reason}
        for row in table.itertuples()
        if row.status != "done"
    ]

    # the rate of the last 40 results (_N_LATEST_RESULTS), by the times of their files
    n_waiting_points = len(points) - len(table)
    times_of_results = []
    for address in set(table["address"]):
        with suppress(FileNotFoundError):  # set aside meanwhile
            times_of_results.append(store.path(address).stat().st_mtime)
    rate = _results_per_second(sorted(times_of_results)[-_N_LATEST_RESULTS:])
    counts = {"done": len(table) - len(failures), "failed": len(failures)}
    return {
        "title": study.get("title", ""),
        "points": counts | {"waiting": n_waiting_points, "total": len(points)},
        "seconds_left": n_waiting_points / rate if n_waiting_points and rate else None,
        "damaged": store.damaged(),
        "failures": failures,
        "notes": [
            {"note": note, "points": count}
            for note, count in Counter(filter(None, table["notes"])).most_common()
        ],
        "table": table,
    }


def _results_per_second(times: Sequence[float]) -> float | None:
    """Results in a second, by the `times` of their files in ascending order [s]; None for fewer
    than two results, or where all have one time.
    """
    if len(times) < 2 or times[-1] <= times[0]:
        return None
    return (len(times) - 1) / (times[-1] - times[0])


def write_page(store: Store) -> Path:
    """Write the page of a sweep to DIR/sweep.html, and the table DIR/index.csv that it links to,
    DIR being the folder of the `store` of results. Returns the path of the page.
    """
    state = sweep_state(store)  # how far the sweep is: counts, failures, notes
    table = state["table"]  # a row for each point that has a result
    stored_study, _ = store.read_plan()
    study = study_of(stored_study, str(store.folder / "sweep.json"))
    scene_title = study.scene.title or study.scene.name

    # how the uncertainties were found; `engines`: "fe" (finite elements), "exact" (theory)
    uncertainty_words = (
        "Theory is exact to rounding at the points and instants at which it is evaluated."
    )
    if "fe" in study.engines:
        # _UNCERTAINTY: a sentence for each way to find uncertainties
        uncertainty_words = _UNCERTAINTY[study.uncertainty]

    # table (250 rows of it) and plots; the script of the page, with its hash
    heads, rows = table_in_words(table[:_MOST_ROWS], study.axes, study.scene)
    figures = draw_figures(table, study.axes, study.scene)
    page_script, script_hash = script()
    page_text = template("sweep.html").render(
        title=study.title or f"Sweep of {scene_title}",
        purpose=study.purpose,
        scene=scene_title,
        engines=" and ".join(_ENGINES[engine] for engine in study.engines),
        uncertainty=uncertainty_words,
        state=state,
        pictures=figures,
        wide=any(figure.n_columns > 1 for figure in figures),
        script=page_script,
        script_hash=script_hash,
        columns=heads,
        rows=rows,
        more=max(0, len(table) - _MOST_ROWS),
    )
    store.write_table(table)
    store.write_text(store.folder / "sweep.html", page_text)
    return store.folder / "sweep.html"


def table_in_words(
    table: pd.DataFrame, axes: Sequence[Axis], scene: Scene, *, is_short: bool = False
) -> tuple[list[str], list[list[str]]]:
    """A sweep's table as texts: heads with units, and the cells of a row for each point, with its
    coordinates, the values computed there with their uncertainties, status and seconds.

    Parameters
    ----------
    table
        a row for each point
    axes
        of the study, each with the names of its `columns` in the table
    scene
        of the study, which has the units
    is_short
        whether heads are names of quantities as in the study, such as "fe.p0", and status and
        seconds are left out
    """
    columns = [column for axis in axes for column in axis.columns]
    quantities = quantity_columns(table, axes)
    heads = ["point", *(_label_of_axis(axis, column) for axis in axes for column in axis.columns)]
    for quantity in quantities:
        quantity_in_words, unit = label_of(quantity, scene)
        heads.append(f"{quantity if is_short else quantity_in_words} [{unit}]")
    if not is_short:
        heads += ["status", "seconds"]

    # the cells of each row
    rows = []
    for record in table.to_dict("records"):
        cells = [str(record["number"])]
        cells += [_coordinate_text(record[column]) for column in columns]
        cells += [_value_text(record, quantity) for quantity in quantities]
        if not is_short:
            cells += [str(record["status"]), f"{record['seconds']:.2g}"]
        rows.append(cells)
    return heads, rows


def _value_text(record: Mapping[Hashable, Any], figure: str) -> str:
    """A value of a row of a sweep's table (`record`) with its uncertainty, as text; "none" where it
    is missing. `figure` names its column, such as "fe.p0".
    """
    factor = display_factor(figure)  # 100 for errors, which are shown in per cent; else 1
    value = factor * float(record[figure])
    if math.isnan(value):
        return "none"
    uncertainty = factor * float(record.get(f"{figure}.uncertainty", math.nan))
    if math.isnan(uncertainty):
        return significant(value, 4)
    return with_uncertainty(value, uncertainty)


def _coordinate_text(value: Any) -> str:
    """The value of a point on an axis as text."""
    return number(value) if isinstance(value, float) else str(value)


def _label_of_axis(axis: Axis, column: str) -> str:
    """Words of an axis of a sweep with its unit, for a column of the table; of an axis with several
    columns the name of that one.
    """
    if column != axis.name:
        return _in_words(column)
    unit = f" [{axis.unit}]" if axis.unit else ""
    return f"{_in_words(axis.label or axis.name)}{unit}"


# ------------------------------------------------------------------------------------------ figures
def _in_words(name: str) -> str:
    """A name of the program as words: with blanks for "_"."""
    return name.replace("_", " ")


def quantity_columns(table: pd.DataFrame, axes: Sequence[Axis]) -> list[str]:
    """Names of the columns of a sweep's table that have values of quantities, without those of
    their uncertainties and idealisation errors. `axes` are those of the sweep, each with the names
    of its `columns`.
    """
    coordinate_columns = {column for axis in axes for column in axis.columns}
    # STATUS_COLUMNS: status, seconds, reason, notes and address
    further_columns = {"number", *STATUS_COLUMNS, *coordinate_columns}
    return [
        name
        for name in table.columns
        if name not in further_columns and not name.endswith((".uncertainty", ".idealisation"))
    ]


def draw_figures(table: pd.DataFrame, axes: Sequence[Axis], scene: Scene) -> list[Plate]:
    """A figure of each quantity of a sweep that has values, in the units of the `scene` that the
    sweep varies. `table` has a row for each point; points that failed are left out.
    """
    solved_rows = solved_rows_of(table)
    figures = [
        _QuantityFigure(name, solved_rows, axes, scene)
        for name in quantity_columns(solved_rows, axes)
    ]
    return [figure.plate() for figure in figures if np.isfinite(figure.value).any()]


class _QuantityFigure:
    """One figure of a table. Over one axis lines with bars; over two a map with its numbers where
    they are a grid, and lines along each of the two; else dots. Each combination of the other axes
    has its own.
    """

    def __init__(self, name: str, table: pd.DataFrame, axes: Sequence[Axis], scene: Scene) -> None:
        """Take from a sweep's table what the plot of one quantity (`name`, such as "fe.p0") needs.
        These are its values at all n points with their uncertainties, in the unit that is shown,
        and the words of the plot.

        Where the table has the idealisation error of that quantity, the error is drawn, with the
        same uncertainty: the difference from theory without the errors of mesh and load increments.
        `axes` are those of the sweep; `scene`, which the sweep varies, has the units.
        """
        self.name = name
        self.table = table
        self.axes = {column: axis for axis in axes for column in axis.columns}  # by column

        # values and uncertainties, (n,) each
        self.value_column = name
        if f"{name}.idealisation" in table:
            self.value_column = f"{name}.idealisation"
        factor = display_factor(name)  # 100 for errors, which are shown in per cent; else 1
        self.value = factor * table[self.value_column].to_numpy(float)
        self.uncertainty = np.full(len(table), np.nan)
        if f"{name}.uncertainty" in table:
            self.uncertainty = factor * table[f"{name}.uncertainty"].to_numpy(float)
        # ends of the bars, (n,); the value itself where its uncertainty is not known
        bar_length = np.nan_to_num(self.uncertainty)
        self.lower_ends = self.value - bar_length
        self.upper_ends = self.value + bar_length
        # (n,) an error that is not larger than its uncertainty
        self.is_unresolved = (np.abs(self.value) <= self.uncertainty) & is_error(name)

        # words of the plot
        self.title_words, self.unit = label_of(name, scene)
        if self.value_column != name:
            self.title_words += ", idealisation error"
        label = "finite elements/theory − 1" if is_error(name) else _in_words(name)
        self.axis_words = f"{label}  [{self.unit}]"

    def plate(self) -> Plate:
        """The figure of one quantity of a sweep with caption and numbers: lines over one axis, a
        map over two that form a grid, else dots. Each combination of values on axes of words, such
        as two kinds of bodies, has a curve or panel of its own.

        `table` has a row for each point of the sweep and a column for each of `axes`; `value` and
        `uncertainty` are those of the quantity, one for each row.
        """
        varied_axes = [name for name in self.axes if self.table[name].nunique() > 1]
        # axes of words, such as kinds of bodies, and axes of numbers
        word_axes = [name for name in varied_axes if self._has_words(name)]
        number_axes = [name for name in varied_axes if name not in word_axes]
        stem = self.value_column.replace(".", "-")
        title = self.title_words
        csv_columns = {
            **{column: self.coordinates(column) for column in number_axes},
            f"{self.value_column} [{self.unit}]": self.value,
            "uncertainty": self.uncertainty,
        }
        if not number_axes:
            caption = (
                f"{number(float(self.value[0]))}: the sweep has one point on every axis of numbers"
            )
            # Plate: name, title, caption, description, panels, CSV table, legend, panels in a row
            return Plate(stem, title, caption, caption, (), csv_columns)

        # for the first six combinations (_MOST_PANELS), which rows belong to them
        combination_of_rows = self._values_in_words(word_axes)  # as text, one for each row
        combinations = np.unique(combination_of_rows).tolist()
        masks = [
            (combination, combination_of_rows == combination)
            for combination in combinations[:_MOST_PANELS]
        ]
        panels, legend, signs_in_words = self._panels(stem, masks, number_axes)

        # the caption, with what bars, hollow dots and colours mean
        if not np.isfinite(self.uncertainty).any():
            signs_in_words = "without uncertainty"
        axes_in_words = " and ".join(self.label(name) for name in number_axes[:2])
        caption = f"Over {axes_in_words}; {signs_in_words}."
        if len(combinations) > _MOST_PANELS:
            caption += (
                f" {len(combinations) - _MOST_PANELS} more sets of the other axes are in index.csv."
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
        """The panels of the figure of one quantity of a sweep, its legend, and what its signs
        (bars, hollow dots, hatching, colours) mean, in words.

        Parameters
        ----------
        stem
            beginning of the names of panels
        masks
            for each combination of values on axes of words, such as kinds of bodies: the
            combination as text, and whether a point of the sweep belongs to it (n,)
        number_axes
            names of the axes of numbers, at least one
        """
        panels: list[Panel | Cell]

        # one axis: curves; `Key` is an entry of the legend: style of a line, and words
        if len(number_axes) == 1:
            panels = [self.curve_panel(stem, masks, number_axes[0])]
            legend = tuple(
                Key(f"line-{index}", _in_words(combination))
                for index, (combination, _) in enumerate(masks)
                if combination
            )
            return panels, legend, "bars are its uncertainty; hollow: not resolved"

        # two axes of which enough combinations have a point (_LEAST_FILLED_SHARE: 0.3): maps, and
        # curves along each axis
        if len(number_axes) == 2 and self._filled_share(number_axes) > _LEAST_FILLED_SHARE:
            panels = [
                self.map_with_scale(f"{stem}-{index}", mask, number_axes, combination)
                for index, (combination, mask) in enumerate(masks)
            ]
            for index, (_, mask) in enumerate(masks):
                panels += self.panels_along_axes(f"{stem}-{index}", mask, number_axes)
            signs_in_words = (
                "hatched, hollow: not resolved, the error is less than its uncertainty; grey: no"
                " result; bars are the uncertainty"
            )
            return panels, (), signs_in_words

        # else dots over the first axis, coloured by the second
        panels = [
            self.dots_with_scale(f"{stem}-{index}", mask, number_axes, combination)
            for index, (combination, mask) in enumerate(masks)
        ]
        return panels, (), "hollow: not resolved; colour: the second axis"

    def panels_along_axes(self, name: str, mask: Mask, columns: Sequence[str]) -> Iterator[Panel]:
        """Two panels of curves for a map over two axes: one along each axis, with a curve for each
        value of the other axis, which is written in the upper right corner. At most six curves
        (`_N_LOOKS`) are drawn: of many values the first, the last and some between.

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
            coordinate = self.coordinates(other_column)
            values = np.unique(coordinate[mask])
            n_curves = min(len(values), _N_LOOKS)
            drawn_indices = np.unique(np.linspace(0, len(values) - 1, n_curves).round()).astype(int)
            curves = [
                (f"{_in_words(other_column)} = {number(value)}", mask & (coordinate == value))
                for value in values[drawn_indices].tolist()
            ]
            yield self.curve_panel(f"{name}-along-{index}", curves, column, labels_in_corner=True)

    def _has_words(self, column: str) -> bool:
        """Whether an axis, the one of this column, has values that are no numbers."""
        return any(isinstance(value, str | bool) for value in self.table[column].tolist())

    def _values_in_words(self, columns: Sequence[str]) -> NDArray[np.str_]:
        """The values of each of the n points of the sweep on these axes, as one text, (n,)."""
        texts = []
        for row in self.table[list(columns)].to_dict("records"):
            values = [f"{name} = {row[name]}" for name in columns]
            texts.append(", ".join(values))
        return np.array(texts)

    def _filled_share(self, columns: list[str]) -> float:
        """Share of the grid of all values on these axes that has a point of the sweep, 0 to 1."""
        cells = np.prod([self.table[name].nunique() for name in columns])
        return float(len(self.table[columns].drop_duplicates()) / cells)

    def coordinates(self, column: str) -> Array:
        """Values of all n points of the sweep on the axis of this column, (n,)."""
        return self.table[column].to_numpy(float)

    def tooltip(self, row: int) -> str:
        """The text that a pointer shows at the value of a row: quantity, value, unit and remark."""
        remark = ", not resolved" if self.is_unresolved[row] else ""
        return f"{self.title_words}: {number(float(self.value[row]))} {self.unit}{remark}"

    def label(self, column: str) -> str:
        """Words of the axis of this column, with its unit."""
        return _label_of_axis(self.axes[column], column)

    def chart_axis(self, column: str, *, for_cells: bool = False) -> ChartAxis:
        """The axis of a chart for an axis of a sweep, whose values stand in this `column` of its
        table. On a logarithmic axis, and with `for_cells`, ticks stand at the values themselves
        where these are few and apart.

        With `for_cells` it goes half an interval beyond the outer values: in a map each value is
        the middle of a cell.
        """
        # values on the axis, each once, and their places on it
        log = self.axes[column].is_logarithmic
        values = np.unique(self.coordinates(column))
        places = np.log(values) if log else values

        # ends of the axis
        if for_cells:
            ends = cell_borders(values, log=log)[[0, -1]]
        else:
            ends = np.array(axis_limits(places, margin=0.05))
            if log:
                ends = np.exp(ends)
        least_value, largest_value = ends.tolist()

        # ticks at the values
        ticks: tuple[tuple[float, str], ...] = ()
        ticks_have_room = len(values) <= 8 and np.all(np.diff(places) > 0.04 * np.ptp(places))
        if (log or for_cells) and ticks_have_room:
            texts = tick_labels([float(f"{value:.3g}") for value in values])
            ticks = tuple(zip(values.tolist(), texts, strict=True))
        return ChartAxis(least_value, largest_value, self.label(column), log, ticks=ticks)

    def curve_panel(
        self,
        name: str,
        curves: Sequence[tuple[str, Mask]],
        column: str,
        *,
        labels_in_corner: bool = False,
    ) -> Panel:
        """A panel of curves of one quantity of a sweep over one axis, with the uncertainty of each
        value, and a line at zero where the values have both signs.

        Parameters
        ----------
        name
            of the panel
        curves
            for each curve its label, and whether a point of the sweep belongs to it (n,)
        column
            of the sweep's table, with the coordinates on the axis
        labels_in_corner
            whether the labels of the curves stand in the upper right corner
        """
        x_axis = self.chart_axis(column)
        y_axis = self._value_axis(len(curves) if labels_in_corner else 0)
        bands: list[Mark] = []  # they lie below all other marks
        marks: list[Mark] = [Rule(0.0, "zero")] if y_axis.low < 0 < y_axis.high else []
        coordinate = self.coordinates(column)
        for curve_number, (label, mask) in enumerate(curves):
            # rows of the table on this curve, in the order of their coordinates
            rows = np.flatnonzero(mask)[np.argsort(coordinate[mask])]
            style_number = curve_number % _N_LOOKS  # one of six looks of the style sheet
            x = coordinate[rows]
            marks.append(
                Curve(x, self.value[rows], f"line-{style_number}", label or self.title_words)
            )
            if labels_in_corner:
                marks.append(_label_in_corner(label, curve_number, x_axis, y_axis))
            band, bars_and_dots = self._uncertainty_of_curve(rows, x, style_number)
            bands = [*band, *bands]
            marks += bars_and_dots
        alt = f"{self.title_words} over {self.label(column)}"
        return Panel(name, x_axis, y_axis, [*bands, *marks], alt, 480.0, 340.0)

    def _uncertainty_of_curve(
        self, rows: NDArray[np.intp], x: Array, style_number: int
    ) -> tuple[list[Mark], list[Mark]]:
        """The marks of the points of a curve with their uncertainties. First those that lie below
        all curves: a band, or none; then those on the curve: bars and dots.

        A curve of up to 120 points (`_MOST_DOTS`) has bars, and a dot for each point. A longer one
        has a band, and dots only where the value is not resolved: so the page stays small.

        Parameters
        ----------
        rows, x
            (k,) indices of the points of the sweep on the curve, and their coordinates
        style_number
            number of the look of the curve in the style sheet
        """
        lower_ends = self.lower_ends[rows]
        upper_ends = self.upper_ends[rows]
        if len(rows) > _MOST_DOTS:
            band = Band(x, lower_ends, upper_ends, f"p{style_number} pale")
            return [band], [*self._dots_of_curve(rows, x, style_number, marks_resolved=False)]
        bars = bar_curve(x, lower_ends, upper_ends, f"line-{style_number}")
        return [], [bars, *self._dots_of_curve(rows, x, style_number, marks_resolved=True)]

    def _value_axis(self, n_labels: int = 0) -> ChartAxis:
        """The axis of the values of the quantity, upwards, with their uncertainties; longer at its
        upper end by the room for so many labels under each other.
        """
        sizes = np.abs([*self.lower_ends, *self.upper_ends])
        largest_size = float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))
        least_value, largest_value = axis_limits(
            self.lower_ends, self.upper_ends, least_range=_LEAST_RANGE_OF_VALUES * largest_size
        )
        # _WORD_HEIGHT: 0.055 of the range, for each label
        largest_value += _WORD_HEIGHT * n_labels * (largest_value - least_value)
        return ChartAxis(least_value, largest_value, self.axis_words)

    def _dots_of_curve(
        self, rows: NDArray[np.intp], x: Array, style_number: int, *, marks_resolved: bool
    ) -> Iterator[Dot]:
        """The dots of a curve of the quantity: hollow ones where its value is not resolved (an
        error that is no larger than its uncertainty), and filled ones at the other points with
        `marks_resolved`.

        Parameters
        ----------
        rows
            (k,) indices of the points of the sweep on the curve
        x
            (k,) their coordinates
        style_number
            number of the look of the line and of the fill in the style sheet
        """
        look = f"line-{style_number}"
        for dot_x, dot_y, is_unresolved in zip(
            x.tolist(), self.value[rows].tolist(), self.is_unresolved[rows], strict=True
        ):
            if is_unresolved:
                yield Dot(dot_x, dot_y, f"{look} hollow", 3.0)
            elif marks_resolved:
                yield Dot(dot_x, dot_y, f"{look} p{style_number}", 3.0)

    def map_with_scale(self, name: str, mask: Mask, columns: list[str], combination: str) -> Cell:
        """A map of one quantity of a sweep over two axes (`columns`): a panel with a coloured
        rectangle for each point of `mask` (n,), and the scale of colours beneath. Where there are
        at most 64 rectangles (`_MOST_NUMBERED_CELLS`), each has its value written on it.
        `combination` says in words which values of the other axes the map is for.

        `value` has the quantity at all n points of the sweep; `is_unresolved` is true for an error
        that is no larger than its uncertainty, whose rectangle is hatched.
        """
        x_axis, y_axis = (self.chart_axis(column, for_cells=True) for column in columns)
        x, y = map(self.coordinates, columns)
        # rectangles, each with the text that a pointer shows, and values on them
        tooltips = [self.tooltip(row) for row in range(len(self.value))]
        colour_share = np.where(mask, self._colour_shares_of_values(), np.nan)
        marks = heat_map((x_axis, y_axis), (x, y), colour_share, tooltips, self.is_unresolved)
        rows = np.flatnonzero(mask & np.isfinite(self.value)).tolist()
        if len(rows) <= _MOST_NUMBERED_CELLS:
            marks += [
                Note(x[row], y[row], significant(self.value[row], 3), "tick over", "middle", (0, 4))
                for row in rows
            ]

        alt = f"Map of {self.title_words}, {combination}"
        panel = Panel(name, x_axis, y_axis, marks, alt, 480.0, 360.0, _in_words(combination))
        if self._has_one_value:
            # Cell: panels one under the other; None: a click on them shows no instant
            return Cell((panel,), None)
        scale = colour_scale(f"{name}-colours", self._ends_of_values, self.axis_words)
        return Cell((panel, scale), None)

    @property
    def _ends_of_values(self) -> tuple[float, float]:
        """Least and largest value of the quantity at any point of the sweep."""
        return float(np.nanmin(self.value)), float(np.nanmax(self.value))

    @property
    def _has_one_value(self) -> bool:
        """Whether the values of the quantity differ by no more than round-off (`_ROUNDOFF_SPREAD`,
        1e-9 of the largest), so that they have one colour.
        """
        least_value, largest_value = self._ends_of_values
        largest_size = max(abs(least_value), abs(largest_value))
        return largest_value - least_value <= _ROUNDOFF_SPREAD * largest_size

    def _colour_shares_of_values(self) -> Array:
        """Place of the value of each of the n points on the scale of colours, (n,), from 0 at the
        least value to 1 at the largest; 0 where all have one value, NaN where there is none.
        """
        least_value, largest_value = self._ends_of_values
        value_range = math.inf if self._has_one_value else largest_value - least_value
        return np.asarray((self.value - least_value) / value_range)

    def dots_with_scale(self, name: str, mask: Mask, columns: list[str], combination: str) -> Cell:
        """A panel with a dot for each point of `mask` (n,), and the scale of its colours beneath. A
        dot shows the value of one quantity of a sweep over the first of the axes `columns`, with a
        bar for its uncertainty; its colour is the second coordinate. `combination` says in words
        which values of the other axes it is for.
        """
        x, second_coordinate = map(self.coordinates, columns[:2])
        x_axis, colour_axis = map(self.chart_axis, columns[:2])
        # from lower_ends to upper_ends: the value minus and plus its uncertainty
        bars = bar_curve(x[mask], self.lower_ends[mask], self.upper_ends[mask], "faint")
        rows = np.flatnonzero(mask & np.isfinite(self.value)).tolist()
        dots = self._coloured_dots(rows, x, _shares_along(colour_axis, second_coordinate))
        marks: list[Mark] = [bars, *dots]
        alt = f"{self.title_words} over {x_axis.words}, {combination}"
        panel = Panel(
            name, x_axis, self._value_axis(), marks, alt, 480.0, 340.0, _in_words(combination)
        )
        scale = colour_scale(
            f"{name}-colours",
            (colour_axis.low, colour_axis.high),
            colour_axis.words,
            log=colour_axis.log,
        )
        # Cell: panels one under the other; None: a click on them shows no instant
        return Cell((panel, scale), None)

    def _coloured_dots(self, rows: Sequence[int], x: Array, colour_share: Array) -> Iterator[Dot]:
        """Dots of the values of the quantity at some points of the sweep (`rows`), over x: hollow
        ones where the value is not resolved (an error that is no larger than its uncertainty), else
        filled with their colour. `x` and `colour_share` (n,) are those of all points; the share is
        the position on the scale of colours, 0 to 1.
        """
        for row in rows:
            look = "faint hollow" if self.is_unresolved[row] else ""
            fill = "" if look else colours_of([colour_share[row]])[0]
            yield Dot(
                float(x[row]), float(self.value[row]), look, 3.6, self.tooltip(row), fill=fill
            )


def _label_in_corner(label: str, curve_number: int, x_axis: ChartAxis, y_axis: ChartAxis) -> Note:
    """The label of a curve in the upper right corner of its panel, under those of the curves before
    it; `curve_number` counts from 0.
    """
    look = f"tick over t{curve_number}"
    shift = (-4.0, 14.0 + 15.0 * curve_number)  # right and down [pixels]
    return Note(x_axis.high, y_axis.high, label, look, "end", shift)


def _shares_along(axis: ChartAxis, coordinates: Array) -> Array:
    """Places of coordinates (n,) along an axis, (n,): 0 at its lower end, 1 at the upper one. They
    are shares of the logarithm on a logarithmic axis.
    """
    ends = np.array([axis.low, axis.high])
    if axis.log:
        return np.interp(np.log(coordinates), np.log(ends), [0.0, 1.0])
    return np.interp(coordinates, ends, [0.0, 1.0])


def bar_curve(x: Array, lower_ends: Array, upper_ends: Array, look: str) -> Curve:
    """Upright bars from `lower_ends` to `upper_ends` at each x, (n,) each, as one curve in a look
    of the style sheet, which breaks (NaN) after each bar.
    """
    breaks = np.full(len(x), np.nan)
    return Curve(
        np.column_stack([x, x, breaks]).ravel(),
        np.column_stack([lower_ends, upper_ends, breaks]).ravel(),
        f"{look} bar-line",
    )


def heat_map(
    axes: tuple[ChartAxis, ChartAxis],
    coordinates: tuple[Array, Array],
    colour_share: Array,
    tooltips: Sequence[str],
    is_hatched: Mask,
) -> list[Mark]:
    """The marks of a map over two axes: a grey ground, and on it a coloured rectangle around each
    of n places.

    Parameters
    ----------
    axes
        of the panel, across and up
    coordinates
        (n,) of the places on each of the two axes
    colour_share
        (n,) position of the colour on the scale of colours, from 0 to 1; where it is NaN there is
        no rectangle
    tooltips
        text that a pointer shows on each rectangle
    is_hatched
        (n,) whether the rectangle is hatched
    """
    x_axis, y_axis = axes
    # the ground; then for each place the lower and upper border of its rectangle, on each axis
    marks: list[Mark] = [Block((x_axis.low, x_axis.high), (y_axis.low, y_axis.high), "no-value")]
    cells_across = _borders_around_places(x_axis, coordinates[0])
    cells_up = _borders_around_places(y_axis, coordinates[1])
    for row in np.flatnonzero(np.isfinite(colour_share)).tolist():
        fill = colours_of([colour_share[row]])[0]
        has_hatching = bool(is_hatched[row])
        marks.append(Block(cells_across[row], cells_up[row], "", tooltips[row], fill, has_hatching))
    return marks


def _borders_around_places(axis: ChartAxis, places: Array) -> list[tuple[float, float]]:
    """Both borders of the cell around each place (n,) on an axis: a cell for each different place,
    which is its middle.
    """
    middles, cell_indices = np.unique(places, return_inverse=True)
    borders = cell_borders(middles, log=axis.log)
    lower_borders = borders[cell_indices].tolist()
    upper_borders = borders[cell_indices + 1].tolist()
    return list(zip(lower_borders, upper_borders, strict=True))


def cell_borders(middles: Array, *, log: bool = False) -> Array:
    """Borders (n + 1,) of cells that lie side by side on an axis, from their middles (n,) in rising
    order: half-way between two middles (on a logarithmic scale with `log`). The outer borders are
    as far beyond the outer middles as the inner ones are before them.

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
