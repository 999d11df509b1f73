"""Figures of the error budget and of the convergence with the mesh."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from reports.charts.plate import (
    Axis,
    Block,
    Curve,
    Dot,
    Key,
    Mark,
    Note,
    Panel,
    Plate,
    Segments,
    figure_with_texts,
)
from reports.charts.templating import Table
from reports.comparison.budget import (
    ROUND_OFF_OF_METRIC,
    Budget,
    ErrorBudget,
    Refinement,
    extrapolate,
)
from reports.comparison.why import Why, percent_of
from reports.comparison.words import value_in_words
from reports.page.cycle_view import LINE_LOOKS, broad_panel
from reports.units import minus
from scenes.array_types import Array

if TYPE_CHECKING:
    from reports.scoring.study import MeshStudy

# Height of the row of a bar [pixels].
_BAR_HEIGHT = 44.0
# A bar that is so many times as long as the median of the bars is cut off, so that others can be
# read.
_LONGEST_OVER_MEDIAN = 3.0


def budget_bars(budget: ErrorBudget) -> Plate | None:
    """A figure with a stacked bar for each metric that has a tolerance: what each source of error
    (a term of the budget: mesh, load steps, ...) adds to the metric's difference E, over the
    tolerance.

    Terms that add to E lie right of zero, those that subtract lie left; their sum is E. Where no
    metric has a tolerance, the metrics of the page's first table are drawn in per cent. None where
    there are none.

    An entry of `budget.budgets` is the budget of one metric: its terms, and whether the bodies are
    the half-planes of theory. Then the rest of E is unexplained, else it is the idealisation error.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend.
    """
    budgets_with_tolerance = [
        budget_of_metric for budget_of_metric in budget.budgets if budget_of_metric.metric.tolerance
    ]
    budgets_of_first_table = [
        budget_of_metric for budget_of_metric in budget.budgets if budget_of_metric.metric.headline
    ]
    drawn_budgets = budgets_with_tolerance or budgets_of_first_table
    if not drawn_budgets:
        return None

    is_judged = bool(budgets_with_tolerance)
    rest_name = "unexplained" if drawn_budgets[0].are_half_planes else "idealisation"
    term_names = [term.name for term in drawn_budgets[0].terms]
    block_names = [*term_names, rest_name]
    # lengths of the blocks of each bar, in tolerances or per cent
    stacks = [_stack_of(budget_of_metric, is_judged) for budget_of_metric in drawn_budgets]
    # legend of the sources of error that have a block in some bar
    is_drawn = np.any([stack.lengths != 0 for stack in stacks], axis=0)
    keys = [
        Key(f"term-{index}", name, is_patch=True)
        for index, name in enumerate(block_names)
        if is_drawn[index]
    ]
    numbers_by_column = _budget_table(drawn_budgets, term_names, rest_name)
    panel = _panel_of_bars(stacks, block_names, is_judged)
    return figure_with_texts(
        "budget", [panel], numbers_by_column, keys, n_columns=1, judged=is_judged
    )


def _panel_of_bars(stacks: Sequence[_Stack], block_names: Sequence[str], is_judged: bool) -> Panel:
    """A panel with a stacked bar for each metric, the first on top, each with a label above it.

    Parameters
    ----------
    stacks
        of each bar the lengths of its blocks, its total and the uncertainty of that
    block_names
        what each block stands for: the sources of error, then what no source explains
    is_judged
        whether lengths are multiples of the tolerance; else they are in per cent
    """
    axis_end = _half_width_of_bars(stacks, is_judged)
    marks: list[Mark] = []
    for row_number, stack in enumerate(stacks):
        # a row has height 1; the first is on top
        bottom_of_row = float(len(stacks) - row_number - 1)
        marks += _limits_of_bar(bottom_of_row, is_judged)
        marks += _blocks_of_bar(bottom_of_row, stack, block_names, is_judged)
        marks += _marks_of_total(bottom_of_row, stack.total, stack.uncertainty, axis_end)
        metric = stack.budget.metric
        # how far the bar with its uncertainty goes from zero
        cut_in_words = ", cut off" if stack.largest_distance > axis_end else ""
        label = f"{metric.label}: {value_in_words(metric)}{cut_in_words}"
        marks.append(_label_of_row(-axis_end, bottom_of_row, label))
    return _panel_of_rows(
        "budget",
        Axis(-axis_end, axis_end, _axis_of_bars(is_judged), n_ticks=8),
        len(stacks),
        marks,
        "Error budget as stacked bars",
    )


def _label_of_row(left_end: float, bottom_of_row: float, label: str) -> Note:
    """The text above a bar, at the left end of the axis. `bottom_of_row` is the height at which the
    row of the bar begins; a row has height 1.
    """
    return Note(left_end, bottom_of_row + 0.7, label, "tick over", shift=(6.0, 0.0))


def _panel_of_rows(name: str, axis: Axis, n_rows: int, marks: Sequence[Mark], alt: str) -> Panel:
    """A panel of level bars along `axis`, in `n_rows` rows of height 1, which are 44 pixels high.
    `name` is that of the panel on the page; `alt` says what it shows, for readers who can't see it.

    `marks` are what is drawn on it.
    """
    # _BAR_HEIGHT: height of the row of a bar [pixels]
    return broad_panel(
        name,
        axis,
        Axis(0.0, float(n_rows), "", n_ticks=0),
        marks,
        alt,
        _BAR_HEIGHT * n_rows + 60,
        room=(20.0, 12.0, 20.0, 46.0),
    )


def _axis_of_bars(is_judged: bool) -> str:
    """Words of the axis along the bars."""
    return "share of the tolerance" if is_judged else "per cent"


def waterfall(why: Why) -> Plate | None:
    """A waterfall figure of the dissipation W: from half-plane theory, at zero, a bar for each
    cause of the difference leads to the finite elements, in per cent of theory's W. None where the
    difference is not split into causes.

    A part of `why` has its cause in words, its change of W (a value with uncertainty, both over
    theory's W), and the sum of the changes before it. `why.difference` is the sum of all.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Note`
    is a text and `Segments` straight lines.
    """
    parts = why.all_parts
    if not parts:
        return None
    total_change = 100 * why.difference.value
    uncertainty = 100 * why.difference.uncertainty
    if not math.isfinite(uncertainty):
        uncertainty = 0.0
    axis = _axis_of_waterfall(why, total_change, uncertainty)
    marks: list[Mark] = []
    labels: list[Mark] = []  # on top of all lines
    n_rows = len(parts) + 1  # of height 1, the first on top, the total in the last
    for part_number, part in enumerate(parts):
        bottom_of_row = float(n_rows - part_number - 1)
        label = f"{part.cause}: {percent_of(part.change)}"
        ends_of_bar = (100 * part.sum_before, 100 * (part.sum_before + part.change.value))
        marks += _bar_of_cause(ends_of_bar, bottom_of_row, f"term-{part_number} edge", label)
        labels.append(_label_of_row(axis.low, bottom_of_row, label))
    marks.append(Segments(np.array([[[0.0, 0.06], [0.0, 0.56]]]), "zero"))
    marks += _marks_of_total(0.0, total_change, uncertainty, max(-axis.low, axis.high))
    label_of_total = f"finite elements/theory − 1: {percent_of(why.difference)}"
    marks += [*labels, _label_of_row(axis.low, 0.0, label_of_total)]
    panel = _panel_of_rows(
        "waterfall", axis, n_rows, marks, "From theory to finite elements, step by step"
    )
    table: Table = {
        "cause": [part.cause for part in parts],
        "change of W": [part.change.value for part in parts],
        "u": [part.change.uncertainty for part in parts],
    }
    return figure_with_texts("waterfall", [panel], table, n_columns=1)


def _axis_of_waterfall(why: Why, total_change: float, uncertainty: float) -> Axis:
    """The axis of the changes of the dissipation W in per cent, with about eight ticks: it holds
    zero, the ends of the bars of all causes, and the total with its uncertainty [per cent], with a
    margin.
    """
    ends_of_bars = [100 * (part.sum_before + part.change.value) for part in why.all_parts]
    least_value = min(0.0, *ends_of_bars, total_change - uncertainty)
    largest_value = max(0.0, *ends_of_bars, total_change + uncertainty)
    margin = 0.08 * (largest_value - least_value) or 1.0
    return Axis(least_value - margin, largest_value + margin, "change of W, per cent", n_ticks=8)


def _bar_of_cause(
    ends_of_bar: tuple[float, float], bottom_of_row: float, css: str, label: str
) -> Iterator[Mark]:
    """What is drawn for one cause in a waterfall figure: a piece of the zero line, a line down to
    the next bar, and the bar itself where it has a length.

    `Block` is a rectangle and `Segments` straight lines.

    Parameters
    ----------
    ends_of_bar
        sum of the changes before this cause, and with it [per cent]
    bottom_of_row
        height at which the row of the bar begins; a row has height 1
    css, label
        class of the bar in the style sheet, and its text
    """
    start_of_bar, end_of_bar = ends_of_bar
    yield Segments(np.array([[[0.0, bottom_of_row + 0.06], [0.0, bottom_of_row + 0.56]]]), "zero")
    # with a gap for the label of the next bar
    line_to_next_bar = np.array(
        [
            [[end_of_bar, bottom_of_row + 0.14], [end_of_bar, bottom_of_row]],
            [[end_of_bar, bottom_of_row - 0.36], [end_of_bar, bottom_of_row - 0.5]],
        ]
    )
    yield Segments(line_to_next_bar, "limit")
    if end_of_bar != start_of_bar:
        yield Block(ends_of_bar, (bottom_of_row + 0.14, bottom_of_row + 0.5), css, label)


class _Stack(NamedTuple):
    """The stacked bar of a metric; lengths are over the metric's tolerance, or per cent.

    Attributes
    ----------
    budget
        the error budget of the metric
    lengths
        (k,) of the blocks: one for each term of the budget, then what no term explains; with sign
    total, uncertainty
        difference E of the metric, and its uncertainty
    """

    budget: Budget
    lengths: Array
    total: float
    uncertainty: float

    @property
    def largest_distance(self) -> float:
        """How far the bar with its whisker goes from zero, on the longer side."""
        right_length = float(self.lengths[self.lengths > 0].sum())
        left_length = float(-self.lengths[self.lengths < 0].sum())
        return max(right_length, left_length, abs(self.total) + self.uncertainty)


def _stack_of(budget_of_metric: Budget, is_judged: bool) -> _Stack:
    """The budget of a metric as lengths of a stacked bar: over its tolerance where `is_judged`,
    else in per cent. What is unknown or infinite has no length.

    A term of the budget is the error by one source; the rest of the error is what no term explains.
    """
    unit = 0.01
    if is_judged:
        unit = budget_of_metric.metric.tolerance or 1.0

    def length_of(value: float | None) -> float:
        """Length of the block for an error."""
        length = (value or 0.0) / unit
        return length if math.isfinite(length) else 0.0

    lengths = [length_of(term.value) for term in budget_of_metric.terms]
    lengths.append(length_of(budget_of_metric.rest_of_error))
    length_of_total = length_of(budget_of_metric.error)
    uncertainty = length_of(budget_of_metric.uncertainty)
    return _Stack(budget_of_metric, np.array(lengths), length_of_total, uncertainty)


def _half_width_of_bars(stacks: Sequence[_Stack], is_judged: bool) -> float:
    """Half the width of the axis: that of the longest bar, at most three times the median of the
    bars. The limits of the tolerance at ±1 are always on it.
    """
    distances = [stack.largest_distance for stack in stacks]
    longest_bar = min(max(distances), _LONGEST_OVER_MEDIAN * float(np.median(distances))) or 1.0
    return 1.08 * max(1.05 if is_judged else 0.0, longest_bar)


def _limits_of_bar(bottom_of_row: float, is_judged: bool) -> Iterator[Mark]:
    """Lines at zero and, where `is_judged`, at the limits ±1 of the tolerance. They end beside the
    bar: on a phone labels would cross them.
    """
    lines = [(0.0, "zero")]
    if is_judged:
        lines += [(-1.0, "limit"), (1.0, "limit")]
    for x, css in lines:
        yield Segments(np.array([[[x, bottom_of_row + 0.06], [x, bottom_of_row + 0.56]]]), css)


def _blocks_of_bar(
    bottom_of_row: float, stack: _Stack, block_names: Sequence[str], is_judged: bool
) -> Iterator[Mark]:
    """The blocks of one stacked bar of a figure, a rectangle for each source of error: to the right
    of zero contributions that add to the difference, to the left those that subtract. A block
    without length is left out.

    Parameters
    ----------
    bottom_of_row
        height at which the row of the bar begins; a row has height 1
    stack
        `lengths` of the blocks, with their signs, in the order of `block_names`
    block_names
        the sources of error, then what no source explains
    is_judged
        whether lengths are multiples of the tolerance; else they are in per cent
    """
    right_end_of_bar = 0.0
    left_end_of_bar = 0.0
    unit = "of the tolerance" if is_judged else "%"
    for index, (length, name) in enumerate(zip(stack.lengths.tolist(), block_names, strict=True)):
        if length > 0:
            start_of_block = right_end_of_bar
            right_end_of_bar += length
        else:
            start_of_block = left_end_of_bar
            left_end_of_bar += length
        if length:
            # `minus`: with a real minus sign
            label = minus(f"{name}: {length:+.3g} {unit}")
            ends_of_block = (start_of_block, start_of_block + length)
            yield Block(
                ends_of_block,
                (bottom_of_row + 0.14, bottom_of_row + 0.5),
                f"term-{index} edge",
                label,
            )


def _budget_table(budgets: Sequence[Budget], term_names: Sequence[str], rest_name: str) -> Table:
    """The numbers of the budget figure as a table by column, a row for each metric: tolerance,
    difference E, the contribution of each source of error (`term_names`), what is left of E (in the
    column `rest_name`), and uncertainty u. NaN where there is no value. A budget has the terms of
    one metric, in the order of `term_names`.
    """
    columns: dict[str, list[float | None]] = {
        "tolerance": [budget_of_metric.metric.tolerance for budget_of_metric in budgets],
        "E": [budget_of_metric.error for budget_of_metric in budgets],
    }
    for index, name in enumerate(term_names):
        columns[name] = [budget_of_metric.terms[index].value for budget_of_metric in budgets]
    columns[rest_name] = [budget_of_metric.rest_of_error for budget_of_metric in budgets]
    columns["u"] = [budget_of_metric.uncertainty for budget_of_metric in budgets]
    table: dict[str, Any] = {
        "metric": [budget_of_metric.metric.key for budget_of_metric in budgets]
    }
    for name, values in columns.items():
        table[name] = [math.nan if value is None else value for value in values]
    return table


def _marks_of_total(
    bottom_of_row: float, total: float, uncertainty: float, axis_end: float
) -> Iterator[Mark]:
    """What is drawn for a total over a stacked bar: an upright line at its value and a whisker for
    its uncertainty. The axis goes from −`axis_end` to `axis_end`; an arrow head at its end shows
    that line or whisker goes beyond. `bottom_of_row` is the height at which the row of the bar
    begins; a row has height 1. Total and uncertainty are in the unit of the axis.
    """
    height_of_whisker = bottom_of_row + 0.32
    if abs(total) <= axis_end:
        yield Curve([total, total], [bottom_of_row + 0.06, bottom_of_row + 0.58], "total")
    left_end = max(total - uncertainty, -axis_end)
    right_end = min(total + uncertainty, axis_end)
    if right_end > left_end:
        yield Curve([left_end, right_end], [height_of_whisker, height_of_whisker], "whisker")
    for direction in (-1, 1):
        if direction * total + uncertainty > axis_end:
            tip = direction * 0.998 * axis_end
            end_of_head = direction * 0.985 * axis_end
            yield Curve(
                [end_of_head, tip, end_of_head],
                [height_of_whisker - 0.1, height_of_whisker, height_of_whisker + 0.1],
                "whisker",
            )


def mesh_refinement(budget: ErrorBudget) -> Plate | None:
    """A figure of how the metrics of the page's first table converge with the mesh, from the runs
    of an error budget: |metric − its extrapolated value at element size zero| over the element
    size, relative to that of the run itself.

    None for fewer than three meshes, or where no metric converges monotonically.

    A run on a mesh has its `size` (element size over that of the run itself), `values` (key of a
    metric -> value), and a reason where it failed. `headline` metrics are those of the first table.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.
    """
    runs = [run for run in budget.refinements.mesh_runs if not run.failure]
    distances_by_label: dict[str, list[tuple[float, float]]] = {}
    for budget_of_metric in budget.budgets:
        metric = budget_of_metric.metric
        points_of_runs = [(run.size, run.values.get(metric.key)) for run in runs]
        known_points = [
            (size, float(value))
            for size, value in points_of_runs
            if value is not None and math.isfinite(value)
        ]
        if not metric.headline or len(known_points) < 3:
            continue
        sizes = tuple(size for size, _ in known_points)
        values = tuple(value for _, value in known_points)
        # value at size zero, and how the values change with the size
        extrapolation = extrapolate(
            Refinement(sizes, values, formal_order=2.0, rounding=ROUND_OFF_OF_METRIC)
        )
        value_at_zero = extrapolation.value
        if extrapolation.kind == "monotone" and value_at_zero is not None:
            distances_by_label[metric.label] = [
                (size, abs(value - value_at_zero))
                for size, value in known_points
                if value != value_at_zero
            ]
    words_of_axes = "element size, over that of the run", "distance from the value at size zero"
    sizes_of_runs = [run.size for run in runs]
    return _figure_of_convergence(
        "mesh_refinement", words_of_axes, distances_by_label, sizes_of_runs
    )


def study_convergence(study: MeshStudy) -> Plate | None:
    """A figure, for external results on several meshes, of how the metrics of the page's first
    table converge: |metric − its limit at element size zero| over the element size.

    None for fewer than three meshes, or where no metric converges monotonically.

    A level of the study is a mesh, with its element size at the contact. A row holds a metric, its
    values on all meshes, and their extrapolation to size zero.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.
    """
    sizes = [level.size for level in study.levels]
    distances_by_label: dict[str, list[tuple[float, float]]] = {}
    for row in study.metric_rows:
        value_at_zero = row.extrapolation.value
        if not row.metric.headline or row.extrapolation.kind != "monotone" or value_at_zero is None:
            continue
        distances_by_label[row.metric.label] = [
            (size, abs(value - value_at_zero))
            for size, value in zip(sizes, row.values, strict=True)
        ]
    words_of_axes = "element size at the contact", "distance from the value at h = 0"
    return _figure_of_convergence("study", words_of_axes, distances_by_label, sizes)


def _has_positive_distance(points: Sequence[tuple[float, float]]) -> bool:
    """Whether a curve has a distance that a logarithmic axis can show."""
    return any(distance > 0 for _, distance in points)


def _figure_of_convergence(
    name: str,
    words_of_axes: tuple[str, str],
    distances_by_label: Mapping[str, list[tuple[float, float]]],
    element_sizes: Sequence[float],
) -> Plate | None:
    """A figure of the distances of metrics from their limits over the element size, both
    logarithmic, beside lines of order 1 and 2.

    None for fewer than three meshes, or where all distances are 0.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend.

    Parameters
    ----------
    words_of_axes
        words of the horizontal and of the vertical axis
    distances_by_label
        label of a metric -> (element size, distance) of each mesh; a metric whose distances are all
        0 is left out
    element_sizes
        those of all meshes
    """
    points_by_label = {
        label: points
        for label, points in distances_by_label.items()
        if _has_positive_distance(points)
    }
    if len(element_sizes) < 3 or not points_by_label:
        return None

    sizes = np.array(sorted(element_sizes))
    table = _table_of_convergence(points_by_label)
    positive_distances = [distance for distance in table["distance"] if distance > 0]
    x_axis, y_axis = _axes_of_convergence(words_of_axes, sizes, positive_distances)
    curves_of_orders = _curves_of_orders(sizes, max(positive_distances))
    marks: list[Mark] = [*curves_of_orders, *_marks_of_metrics(points_by_label)]
    alt = "Convergence with the mesh, both axes logarithmic"
    panel = broad_panel(name, x_axis, y_axis, marks, alt, 360.0)
    # LINE_LOOKS: classes of lines in the style sheet, one for each metric
    keys = [Key(css, label) for label, css in zip(points_by_label, LINE_LOOKS, strict=False)]
    keys += [Key(curve.css, curve.label) for curve in curves_of_orders]
    return figure_with_texts(name, [panel], table, keys, n_columns=1)


def _table_of_convergence(
    points_by_label: Mapping[str, Sequence[tuple[float, float]]],
) -> dict[str, list[Any]]:
    """Columns for a CSV, a row for each mesh of each metric: label of the metric, element size, and
    distance of the metric from its limit. `points_by_label`: label -> (element size, distance) of
    each mesh.
    """
    all_points = [point for points in points_by_label.values() for point in points]
    return {
        "metric": [label for label, points in points_by_label.items() for _ in points],
        "size": [size for size, _ in all_points],
        "distance": [distance for _, distance in all_points],
    }


def _axes_of_convergence(
    words_of_axes: tuple[str, str], sizes: Array, positive_distances: Sequence[float]
) -> tuple[Axis, Axis]:
    """The logarithmic axes of a figure of convergence: of element size and of distance from the
    limit. Below a millionth of the largest distance a curve is round-off, which is not shown.

    Parameters
    ----------
    words_of_axes
        words of the axis of element size, and of that of distance
    sizes
        (n_meshes,) element sizes
    positive_distances
        distances of all metrics on all meshes, but those that are 0
    """
    words_of_size, words_of_distance = words_of_axes
    largest_distance = max(positive_distances)
    least_distance = max(min(positive_distances), 1e-6 * largest_distance)
    return (
        Axis(0.8 * float(sizes.min()), 1.25 * float(sizes.max()), words_of_size, log=True),
        Axis(least_distance / 3, 3 * largest_distance, words_of_distance, log=True),
    )


def _curves_of_orders(sizes: Array, largest_distance: float) -> list[Curve]:
    """Straight lines of order 1 and 2 in a logarithmic figure of convergence: distance proportional
    to the element size and to its square. Both start at the largest distance on the coarsest mesh.
    `sizes` (n_meshes,) are ascending.
    """
    return [
        Curve(
            sizes,
            largest_distance * (sizes / sizes[-1]) ** order,
            f"slope order-{order}",
            f"order {order}",
        )
        for order in (1, 2)
    ]


def _marks_of_metrics(
    points_by_label: Mapping[str, Sequence[tuple[float, float]]],
) -> Iterator[Mark]:
    """For each metric a curve of its distance from its limit over the element size, and a dot on
    each mesh, but where the distance is 0. `points_by_label`: label of the metric -> (element size,
    distance) of each mesh.
    """
    # LINE_LOOKS: classes of lines in the style sheet, one for each metric
    for (label, points), css in zip(points_by_label.items(), LINE_LOOKS, strict=False):
        curve_sizes = [size for size, _ in points]
        curve_distances = [distance for _, distance in points]
        yield Curve(curve_sizes, curve_distances, css, label)
        for size, distance in points:
            if distance > 0:
                yield Dot(size, distance, f"{css} knot", 3.2)
