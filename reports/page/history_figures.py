"""Figures over time and over load: edges, discrepancies, slip, load path, hysteresis."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from reports.charts.plate import (
    Axis,
    Curve,
    Dot,
    Key,
    Mark,
    Note,
    Panel,
    Plate,
    Rule,
    axis_limits,
    figure_with_texts,
)
from reports.charts.templating import Table
from reports.comparison.cycles import Cycle, Event
from reports.comparison.metrics import JudgedPair, Metric, reason_by_missing_field
from reports.comparison.pairs import are_half_planes
from reports.comparison.work_of_loads import bulk_strain, bulk_work, loop_work
from reports.measured import load_cycles
from reports.page.cycle_view import (
    LINE_LOOKS,
    X_OVER_A,
    ZERO,
    CycleView,
    broad_panel,
    difference_in_words,
    loop_compliance,
    sheared_displacement,
    slip_points,
)
from reports.units import energy_unit, load_unit, minus, signed, units
from scenes import Scene, sampled_times
from scenes.array_types import Array
from scenes.scene import OWN_TOLERANCES

# Discrepancies over their tolerance are drawn up to this ratio; larger ones are cut off.
_LARGEST_DRAWN_RATIO = 8.0
# Of load path and loops, which stand one under the other beside the tractions [units of a
# drawing].
_LOOP_HEIGHT = 220.0


def half_widths(view: CycleView) -> Plate:
    """A figure of the contact edges and stick edges of both engines through the cycle. A second
    panel beside it shows the differences of the half-widths of contact and stick zone, result minus
    reference, per cent of a_ref, the half-width at the reference load.

    `view` holds the last cycles of both solutions: `engines` (cycle, name, class of lines in the
    style sheet) of reference and result, the axis of time, and words for the part of the path.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend.
    """
    curves = _curves_of_edges(view)
    # X_OVER_A: words of the axis, "x / a_ref"
    panel_of_edges = Panel(
        "edges",
        view.over_time(),
        Axis(*axis_limits(*(curve.y for curve in curves)), X_OVER_A),
        curves,
        f"Contact and stick edges through the {view.noun}",
        time="x",
    )
    # an entry for each zone of each engine, whose edges are two curves
    keys = [Key(curve.css, curve.label) for curve in curves[::2]]
    legend = (*keys, Key("d p", "difference, contact"), Key("d q", "difference, stick"))
    # of the result's points
    spacing = _spacing_at_the_edge(view.result_cycle) / view.scales.half_width
    # the named values fill the caption; `stretch` is the part of the path in words, such as "last
    # cycle"
    return figure_with_texts(
        "half_widths",
        (panel_of_edges, _panel_of_half_width_differences(view)),
        _table_of_edges(view),
        legend,
        stretch=view.part_of_path,
        spacing=f"{spacing:.1g}" if np.isfinite(spacing) else "",
    )


def _curves_of_edges(view: CycleView) -> list[Curve]:
    """Curves of the left and the right edge of contact and of stick zone over time, of the
    reference and then of the result: x over a_ref, the half-width at the reference load.

    `view` holds the last cycles of both solutions.
    """
    a_ref = view.scales.half_width
    curves = []
    for engine in view.engines:
        for zone, css in (("contact", "p"), ("stick", "q")):
            left_edge, right_edge = getattr(engine.cycle, f"{zone}_edges").T  # (k,) [length]
            for edge in (left_edge, right_edge):
                label = f"{zone} edge, {engine.name}"
                curves.append(Curve(view.time, edge / a_ref, f"{engine.line_css} {css}", label))
    return curves


def _table_of_edges(view: CycleView) -> Table:
    """Columns (k,) for a CSV: the time, and the left and right edge of contact and of stick zone of
    the reference and of the result [length].

    `view` holds the last cycles of both solutions.
    """
    table = {"time": view.result_cycle.time}
    for role, engine in zip(("reference", "result"), view.engines, strict=True):
        for zone in ("contact", "stick"):
            left_edge, right_edge = getattr(engine.cycle, f"{zone}_edges").T
            table[f"left_{zone}_edges_{role}"] = left_edge
            table[f"right_{zone}_edges_{role}"] = right_edge
    return table


def _panel_of_half_width_differences(view: CycleView) -> Panel:
    """A panel of the differences of the half-widths of contact and stick zone over time, result
    minus reference, in per cent of a_ref. Notes state the size of each.

    `view` holds the last cycles of both solutions, and the axis of time.
    """
    a_ref = view.scales.half_width
    difference_of_zone = {}
    for zone in ("contact", "stick"):
        half_width_of_engine = []  # of the reference and of the result, (k,) over a_ref
        for engine in view.engines:
            left_edge, right_edge = getattr(engine.cycle, f"{zone}_edges").T
            half_width_of_engine.append((right_edge - left_edge) / 2 / a_ref)
        reference_values, result_values = half_width_of_engine
        difference_of_zone[zone] = 100 * (result_values - reference_values)
    # root mean square and largest value of each difference, in words
    notes = [
        f"{zone}: {view.difference_over_time(difference, ' % of a_ref')}"
        for zone, difference in difference_of_zone.items()
    ]
    difference_axis = Axis(
        *axis_limits(*difference_of_zone.values(), with_zero=True, least_range=1e-10),
        "difference, % of a_ref",
    )
    return Panel(
        "edges-difference",
        view.over_time(),
        difference_axis,
        [
            ZERO,  # a line at 0
            Curve(view.time, difference_of_zone["contact"], "d p", "contact"),
            Curve(view.time, difference_of_zone["stick"], "d q", "stick"),
        ],
        "Difference of the half-widths",
        notes=notes,
        time="x",
    )


def _spacing_at_the_edge(cycle: Cycle) -> float:
    """The median distance of neighbouring points whose |x| is within 30 % of that of the outermost
    contact edge [length]; NaN where nothing touches.
    """
    outer_edge = float(np.nanmax(np.abs(cycle.contact_edges), initial=0.0))
    if not outer_edge:
        return math.nan
    is_about_edge = np.abs(np.abs(cycle.x[1:]) - outer_edge) < 0.3 * outer_edge
    return float(np.median(np.diff(cycle.x)[is_about_edge]))


class _DrawnRatios(NamedTuple):
    """The discrepancy of one metric at each instant, as a figure draws it."""

    label: str  # name of the metric
    # (k,) |difference| over the tolerance, or in per cent where the figure has no tolerances; NaN
    # at instants that are not judged
    ratios: Array


def discrepancies(view: CycleView) -> Plate:
    """A figure of how far the result is from the reference through the cycle: for each metric that
    has a tolerance and values over time, |difference| at each judged instant over that tolerance.

    Where none has, the metrics by which half-planes are judged are drawn in per cent.

    `view` holds the comparison and the axis of time. A metric's `series` is its value at each
    instant, (k,).

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend.
    """
    metrics = [metric for metric in view.comparison.metrics if metric.series is not None]
    metrics_with_tolerance = [metric for metric in metrics if metric.tolerance is not None]
    has_tolerances = bool(metrics_with_tolerance)
    # OWN_TOLERANCES: by key, tolerances of metrics by which half-planes are judged
    drawn_metrics = metrics_with_tolerance or [
        metric for metric in metrics if metric.key in OWN_TOLERANCES
    ]
    drawn_ratios = [
        _DrawnRatios(metric.label, _judged_ratios(view, metric, has_tolerances=has_tolerances))
        for metric in drawn_metrics
    ]
    largest_ratio = max(
        (float(np.nanmax(drawn.ratios, initial=0.0)) for drawn in drawn_ratios), default=0.0
    )
    panel = _panel_of_discrepancies(view, drawn_ratios, largest_ratio, has_tolerances)
    legend_entries = _legend_of_discrepancies(view, drawn_ratios, "" if has_tolerances else " %")
    table = {"time": view.result_cycle.time}
    table |= {metric.key: np.asarray(metric.series) for metric in drawn_metrics}
    # the values behind `n_columns` fill the caption; `stretch` is the part of the path in words
    return figure_with_texts(
        "errors",
        [panel],
        table,
        legend_entries,
        n_columns=1,
        judged=has_tolerances,
        cut=has_tolerances and largest_ratio > _LARGEST_DRAWN_RATIO,
        stretch=view.part_of_path,
    )


def _judged_ratios(view: CycleView, metric: Metric, *, has_tolerances: bool) -> Array:
    """|difference| of a metric over its tolerance at each instant, (k,), or in per cent where the
    figure has no tolerances.

    NaN at instants that are not judged: out of contact, or with a normal load below a tenth of the
    reference load. There errors relative to the small traction would measure the mesh only. `view`
    holds the comparison: which of its instants are judged.
    """
    unit_of_ratio = (metric.tolerance or 1.0) if has_tolerances else 0.01
    ratios = np.abs(np.asarray(metric.series)) / unit_of_ratio
    return np.where(view.comparison.is_judged, ratios, np.nan)


def _legend_of_discrepancies(
    view: CycleView, drawn_ratios: Sequence[_DrawnRatios], unit_in_words: str
) -> list[Key]:
    """Entries of the legend: name of each metric, its largest ratio with `unit_in_words` behind it,
    and the time of that, on the axis of the figure.

    `view` holds the times of the figure (k,). `drawn_ratios` has a label and ratios (k,) for each
    metric.
    """
    legend_entries = []
    # `LINE_LOOKS`: classes of lines in the style sheet, one for each metric
    for drawn, css in zip(drawn_ratios, LINE_LOOKS, strict=False):
        is_known = np.isfinite(drawn.ratios)
        worst_index = int(np.nanargmax(drawn.ratios)) if is_known.any() else 0
        text = (
            f"{drawn.label}: {drawn.ratios[worst_index]:.2g}{unit_in_words} at"
            f" {view.time[worst_index]:.3g}"
        )
        # `minus`: with a real minus sign
        legend_entries.append(Key(css, minus(text)))
    return legend_entries


def _panel_of_discrepancies(
    view: CycleView,
    drawn_ratios: Sequence[_DrawnRatios],
    largest_ratio: float,
    has_tolerances: bool,
) -> Panel:
    """A panel with a curve over time for each metric. Where they are over their tolerances, a line
    across the panel marks 1, and ratios above 8 are cut off. `largest_ratio` is the largest of all
    metrics and judged instants.

    `view` holds the times of the figure (k,). `drawn_ratios` has a label and ratios (k,) for each
    metric. `has_tolerances`: whether these are over tolerances, else they are per cent.
    """
    marks: list[Mark] = []
    if has_tolerances:
        marks.append(Rule(1.0, "limit"))
    # `LINE_LOOKS`: classes of lines in the style sheet, one for each metric
    marks += [
        Curve(view.time, drawn.ratios, css, drawn.label)
        for drawn, css in zip(drawn_ratios, LINE_LOOKS, strict=False)
    ]
    if has_tolerances:
        last_time = float(view.time[-1])
        marks.append(Note(last_time, 1.0, "tolerance", anchor="end", shift=(-4.0, -5.0)))
        # _LARGEST_DRAWN_RATIO: 8
        largest_drawn_ratio = min(max(1.0, largest_ratio), _LARGEST_DRAWN_RATIO)
        axis_words = "|discrepancy| / tolerance"
    else:
        largest_drawn_ratio = largest_ratio or 1.0
        axis_words = "|discrepancy|, %"
    return broad_panel(
        "errors",
        view.over_time(8),
        Axis(0.0, 1.08 * largest_drawn_ratio, axis_words),
        marks,
        f"Discrepancy through the {view.noun}",
        time="x",
    )


class _SlipSinceStart(NamedTuple):
    """Slip since the start of the cycle at a few points by both engines, a column for each point,
    (k instants, n_points) [length].
    """

    points: list[int]  # indices of the points among those of the result
    labels: list[str]  # x of each point in words
    reference: Array
    result: Array


def slip_histories(view: CycleView) -> Plate:
    """A figure of the slip of a few points over time, by both engines: the slip since the start of
    the cycle.

    `view` holds the last cycles of both solutions: `engines` (cycle with slip (k, n), name) of
    reference and result, points `x` over a_ref (n,), the half-width at the reference load, and the
    axis of time.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend. `css` is a class of the style sheet.
    """
    # indices of up to four points between the stick zone and the edge of contact
    points = slip_points(view.comparison)
    labels = [f"x = {view.x[point]:.3f} a_ref" for point in points]
    slip_of_reference, slip_of_result = (
        engine.cycle.slip[:, points] - engine.cycle.slip[0, points] for engine in view.engines
    )
    slip_since_start = _SlipSinceStart(points, labels, slip_of_reference, slip_of_result)
    keys = [Key(f"point-{column}", label) for column, label in enumerate(labels)]
    return figure_with_texts(
        "slip_history",
        [_panel_of_slip(view, slip_since_start)],
        _table_of_slip(view, slip_since_start),
        keys,
        n_columns=1,
        stretch=view.part_of_path,
    )


def _panel_of_slip(view: CycleView, slip: _SlipSinceStart) -> Panel:
    """A panel of slip over time: of each point a wide line for the reference and a thin one for the
    result. Notes state the difference at the point where it is largest.

    `view` holds the names of both engines and the axis of time. `slip` has a column for each point,
    (k, n_points) [length].
    """
    _, unit_of_length, _ = units(view.scene)
    slips = (slip.reference, slip.result)
    curves = []
    for line_width, slip_of_engine, engine in zip(
        ("wide", "thin"), slips, view.engines, strict=True
    ):
        for column, label in enumerate(slip.labels):
            css = f"{line_width} point-{column}"
            curves.append(
                Curve(view.time, slip_of_engine[:, column], css, f"{label}, {engine.name}")
            )
    difference = slip.result - slip.reference
    worst_column = int(np.argmax(np.nanmax(np.abs(np.nan_to_num(difference)), axis=0)))
    notes = [
        f"result − reference at {slip.labels[worst_column]}, where it is largest:",
        view.difference_over_time(difference[:, worst_column], f" {unit_of_length}"),
    ]
    least_slip = 1e-12 * view.scales.half_width  # least range of the axis
    return broad_panel(
        "slip",
        view.over_time(8),
        Axis(
            *axis_limits(*slips, with_zero=True, least_range=least_slip),
            f"slip since the start  [{unit_of_length}]",
        ),
        curves,
        "Slip of chosen points over time",
        320.0,
        notes=notes,
        time="x",
    )


def _table_of_slip(view: CycleView, slip: _SlipSinceStart) -> Table:
    """Columns (k,) for a CSV: the time, and the slip of each point since the start of the cycle, by
    both engines [length]. The headings state the x of the point and the unit.

    `view` holds the times (k,) and the points of the result.
    """
    _, unit_of_length, _ = units(view.scene)
    table = {"time": view.result_cycle.time}
    for column, point in enumerate(slip.points):
        place_with_unit = f"(x = {view.result_cycle.x[point]:.6g}) [{unit_of_length}]"
        table[f"slip_reference{place_with_unit}"] = slip.reference[:, column]
        table[f"slip_result{place_with_unit}"] = slip.result[:, column]
    return table


def cumulative_work(view: CycleView) -> Plate | None:
    """A figure of the friction work from the start of a measured record of loads to each instant,
    by each solution that holds it; None for other loads, and where neither does.

    `view` holds the comparison, its scene, and the legend entry (`keys`) of each solution.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `css` is
    a class of the style sheet.
    """
    solutions = (view.comparison.reference, view.comparison.result)
    series = []  # (legend entry, times (n,), work up to each time (n,))
    for key, solution in zip(view.keys, solutions, strict=True):
        # load cycles counted in the record, with the work up to each instant; None for other loads
        cycles_with_work = load_cycles(solution)
        if cycles_with_work is not None:
            series.append((key, cycles_with_work.time, cycles_with_work.cumulative))
    if not series:
        return None
    every_time = np.unique(np.concatenate([time for _, time, _ in series]))
    unit = energy_unit(view.scene)
    table = {"time": every_time}
    for key, time, work in series:
        table[f"W, {key.text} [{unit}]"] = np.interp(every_time, time, work)
    curves = [Curve(time, work, key.css, key.text) for key, time, work in series]
    panel = broad_panel(
        "cumulative-work",
        Axis(*axis_limits(every_time, margin=0.02), "time"),
        Axis(*axis_limits(*(work for *_, work in series), with_zero=True), f"W so far  [{unit}]"),
        curves,
        "Dissipation so far over time",
        260.0,
    )
    return figure_with_texts(
        "cumulative_work",
        [panel],
        table,
        [key for key, *_ in series],
        n_columns=1,
        repeats=view.scene.load.path().period is not None,
    )


def load_path(view: CycleView) -> Plate:
    """A figure of the load path in the P-Q plane: initial loading, cycle, Coulomb limit, dots with
    numbers at chosen instants, and a ring at the instant that the page shows first.

    Beneath it stand bulk stress, tilt and moment over the cycle, where the scene has them.

    `view` holds the last cycles of both solutions, the instants that figures mark by numbers
    (`chosen_events`) and the index of the one that is shown first (`shown_instant`). A class of a
    line in the style sheet is called css.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend.
    """
    scene = view.comparison.result.scene
    # initial loading and cycle, each with P and Q at many instants
    parts = _parts_of_path(scene)
    keys = [Key(part.line_css, part.name) for part in reversed(parts)]
    if scene.friction.coefficient:
        keys.append(Key("cone", "|Q| = f P"))
    panels = [_panel_of_path(view, parts)]
    for name, axis_words, lines_of_panel in _lines_of_bulk_and_tilt(view):
        panels.append(_panel_beneath_path(view, name, axis_words, lines_of_panel))
        keys += [Key(line.css, line.text) for line in lines_of_panel]
    table: Table = {
        "time": np.concatenate([part.time for part in parts]),
        "part": [part.name for part in parts for _ in part.time],
        "P": np.concatenate([part.normal_load for part in parts]),
        "Q": np.concatenate([part.tangential_load for part in parts]),
    }
    has_bulk_or_tilt = len(panels) > 1
    # the values behind `n_columns` fill the caption; `stretch` is the part of the path in words
    return figure_with_texts(
        "load_path",
        panels,
        table,
        keys,
        n_columns=1,
        beside=has_bulk_or_tilt,
        stretch=view.part_of_path,
    )


def _panel_of_path(view: CycleView, parts: Sequence[_PathPart]) -> Panel:
    """A panel of Q over P: the Coulomb limit |Q| = f P, initial loading and cycle (`parts`), dots
    with numbers at chosen instants, and a ring that the page's slider moves along the cycle.

    `view` holds the last cycle of the result, the instants that have a number in figures, and the
    index of that shown first.
    """
    scene = view.comparison.result.scene
    friction_coefficient = scene.friction.coefficient
    end_of_p_axis, start_of_q_axis, end_of_q_axis = _ends_of_load_axes(parts)
    marks: list[Mark] = []
    if friction_coefficient:
        for sign in (1, -1):
            coulomb_limit = sign * end_of_p_axis * friction_coefficient
            marks.append(Curve([0, end_of_p_axis], [0, coulomb_limit], "cone", "|Q| = f P"))
    marks += [
        Curve(part.normal_load, part.tangential_load, part.line_css, part.name) for part in parts
    ]
    unit = load_unit(scene)
    # _LOOP_HEIGHT: 220 pixels
    panel = Panel(
        "load-path",
        Axis(0.0, end_of_p_axis, f"normal load P  [{unit}]"),
        Axis(start_of_q_axis, end_of_q_axis, f"tangential load Q  [{unit}]"),
        marks,
        "Load path in the plane of P and Q",
        height=_LOOP_HEIGHT,
    )
    # dots and ring need the scales of the panel, whose marks they join
    cycle = view.result_cycle
    marks += _numbered_dots(panel, cycle.normal_load, cycle.tangential_load, view.chosen_events)
    shown_normal_load = cycle.normal_load[view.shown_instant]
    shown_tangential_load = cycle.tangential_load[view.shown_instant]
    marks.append(_slider_ring("P", shown_normal_load, "Q", shown_tangential_load, "now"))
    return panel


def _ends_of_load_axes(parts: Sequence[_PathPart]) -> tuple[float, float, float]:
    """The end of the axis of P, which starts from 0, and start and end of the axis of Q [force /
    thickness]: a little beyond the largest and least loads of a load path, given by its `parts`.
    """
    normal_load = np.concatenate([part.normal_load for part in parts])
    tangential_load = np.concatenate([part.tangential_load for part in parts])
    end_of_p_axis = 1.08 * float(normal_load.max())
    end_of_q_axis = 1.25 * max(float(np.abs(tangential_load).max()), 0.15 * end_of_p_axis)
    start_of_q_axis = min(-0.3 * end_of_q_axis, 1.25 * float(tangential_load.min()))
    return end_of_p_axis, start_of_q_axis, end_of_q_axis


def _panel_beneath_path(
    view: CycleView, name: str, axis_words: str, lines: Sequence[_Line]
) -> Panel:
    """A low panel with lines over time (bulk stress, tilt or moment), beneath the load path. `name`
    is that of the panel, `axis_words` are the words of its vertical axis. `view` holds the axis of
    time. A line has values (k,) at the instants, its text, and its class in the style sheet
    (`css`).

    `ZERO` is a line at 0.
    """
    marks: list[Mark] = [ZERO]
    marks += [Curve(view.time, line.values, line.css, line.text) for line in lines]
    values_of_lines = [line.values for line in lines]
    return Panel(
        name,
        view.over_time(),
        Axis(*axis_limits(*values_of_lines, with_zero=True, margin=0.12), axis_words, n_ticks=3),
        marks,
        f"{axis_words} over time",
        height=190.0,
        time="x",
    )


class _PathPart(NamedTuple):
    """Initial loading or cycle of a load path, at k instants: its name, the class of its line in
    the style sheet, and time, P and Q, (k,) each.
    """

    name: str
    line_css: str
    time: Array
    normal_load: Array
    tangential_load: Array


def _parts_of_path(scene: Scene) -> list[_PathPart]:
    """Initial loading and cycle of a scene's load path, each as P and Q at many instants. Where
    nothing repeats, the whole path is one part.
    """
    path = scene.load.path()
    # name, class of the line in the style sheet, load segments
    named_parts = [("path", "loop", path.initial_loading)]
    if path.cycle:
        named_parts = [
            ("initial loading", "initial-loading", path.initial_loading),
            ("cycle", "loop", path.cycle),
        ]
    parts = []
    for name, line_css, segments in named_parts:
        if segments:
            time = np.concatenate([sampled_times(segment, 257) for segment in segments])
            normal_load, tangential_load = path.at(time)
            parts.append(
                _PathPart(
                    name, line_css, time, np.asarray(normal_load), np.asarray(tangential_load)
                )
            )
    return parts


class _Line(NamedTuple):
    """A line of a figure over time."""

    css: str
    text: str
    values: Array


def _lines_of_bulk_and_tilt(view: CycleView) -> Iterator[tuple[str, str, list[_Line]]]:
    """Lines over the cycle for what acts beside P and Q: bulk stress, tilt and moment, as far as
    the scene has them. Each comes as name of a panel, words of its axis with the unit, and lines: a
    class of the style sheet, a text, values (k,). `view.result_cycle` is the last cycle of the
    result; what the scene does not have is None in it. A moment that follows from a stated tilt has
    no line (`moment_is_given` is False).
    """
    unit_of_force, _, stress_unit = units(view.scene)
    cycle = view.result_cycle
    stresses: list[_Line] = []
    for body in ("lower", "upper"):
        stress = getattr(cycle, f"bulk_stress_{body}")
        if stress is not None and np.any(stress):
            stresses.append(_Line(f"line-{len(stresses)} fine", f"σ, {body} body", stress))
    if stresses:
        yield "bulk-stress", f"bulk stress σ  [{stress_unit}]", stresses
    if cycle.tilt is not None and np.any(cycle.tilt):
        yield "tilt", "tilt α  [rad]", [_Line("line-2 fine", "tilt of the upper body", cycle.tilt)]
    if cycle.moment is not None and np.any(cycle.moment) and view.scene.load.moment_is_given:
        yield (
            "moment",
            f"moment M  [{unit_of_force}]",
            [_Line("line-3 fine", "moment", cycle.moment)],
        )


def _numbered_dots(
    panel: Panel, x_values: Array, y_values: Array, events: Sequence[Event]
) -> Iterator[Mark]:
    """Dots on a closed loop at chosen instants, each with its number beside it, outside the loop. A
    number that would lie on another one is left out.

    `Note` is a text.

    Parameters
    ----------
    panel
        in which the loop is drawn
    x_values, y_values
        (k,) coordinates of the loop at all instants, in the units of the panel's axes
    events
        the chosen instants, each with its `index` among all, in the order of their numbers
    """
    x_in_pixels = panel.frame.x.pixels_of(x_values)
    y_in_pixels = panel.frame.y.pixels_of(y_values)
    label_places: list[Array] = []  # of the numbers that are drawn
    for event_number, event in enumerate(events, start=1):
        index = event.index  # of the instant
        event_data = {"event": index}  # a click shows that instant
        # the number stands 13 pixels from its dot, away from the middle of the loop
        dot_place = np.array([x_in_pixels[index], y_in_pixels[index]])
        wanted_shift = 13 * _direction_from_middle(x_in_pixels, y_in_pixels, index)
        shift = _shift_into_box(wanted_shift, dot_place, panel.frame.box)
        label_place = dot_place + shift
        yield Dot(float(x_values[index]), float(y_values[index]), "event", 3.4, data=event_data)
        if all(np.hypot(*(label_place - drawn_place)) > 11 for drawn_place in label_places):
            label_places.append(label_place)
            yield Note(
                float(x_values[index]),
                float(y_values[index]),
                str(event_number),
                "number",
                "middle",
                (float(shift[0]), float(shift[1]) + 4),
                event_data,
            )


def _direction_from_middle(x: Array, y: Array, index: int) -> Array:
    """Unit vector (2,) normal to a curve at one of its points, pointing away from the mean of all
    points. Zero where the curve is a single point.

    `x` and `y` are the coordinates of the curve's points, (n,) each; `index` names the point.
    """
    index_before = max(index - 1, 0)
    index_after = min(index + 1, len(x) - 1)
    normal_vector = np.array([y[index_before] - y[index_after], x[index_after] - x[index_before]])
    vector_from_middle = np.array([x[index] - x.mean(), y[index] - y.mean()])
    if not np.all(np.isfinite(normal_vector)) or not np.hypot(*normal_vector):
        normal_vector = vector_from_middle
    if normal_vector @ vector_from_middle < 0:
        normal_vector = -normal_vector
    return np.asarray(normal_vector / (np.hypot(*normal_vector) or 1.0))


# Half the width and half the height of a label, a number of one or two digits [pixels].
_HALF_LABEL = np.array([5.0, 7.0])


def _shift_into_box(
    wanted_shift: Array, dot_place: Array, box: tuple[float, float, float, float]
) -> Array:
    """The shift (2,) of a label from its dot that keeps the label in the box: the wanted shift
    itself, or mirrored, or else shortened. All in pixels; a label is 10 wide and 14 high.

    Parameters
    ----------
    wanted_shift
        (2,) place of the label minus that of the dot
    dot_place
        (2,) place of the dot
    box
        left, top, right and bottom end of the box
    """
    left_x, top_y, right_x, bottom_y = box
    # _HALF_LABEL: half the width and half the height of a label
    least_place = np.array([left_x, top_y]) + _HALF_LABEL
    largest_place = np.array([right_x, bottom_y]) - _HALF_LABEL
    for signs in ([1, 1], [1, -1], [-1, 1], [-1, -1]):
        label_place = dot_place + signs * wanted_shift
        if np.all((least_place <= label_place) & (label_place <= largest_place)):
            return np.asarray(signs * wanted_shift)
    place_in_box = np.clip(dot_place + wanted_shift, least_place, largest_place)
    return np.asarray(place_in_box - dot_place)


# Radius of the ring at the instant shown [pixels].
_RING_RADIUS = 6.5


def _slider_ring(x_series: str, x_value: float, y_series: str, y_value: float, css: str) -> Dot:
    """A ring (a circle that is not filled) on a curve of Q, at the instant that the page shows
    first. The page's slider moves it along the curve.

    Parameters
    ----------
    x_series, y_series
        names of the curve's coordinates in the data of the page's script: "P" and "Q" of the
        result, or "U0" and "Q0", U and Q of the reference, with which the result is compared
    x_value, y_value
        the coordinates at that instant, in the units of the axes
    css
        class of the ring in the style sheet
    """
    return Dot(
        float(x_value),
        float(y_value),
        f"follow {css}",
        _RING_RADIUS,
        data={"series_x": x_series, "series_y": y_series},
    )


def hysteresis(view: CycleView) -> Plate | None:
    """A figure of the loop of Q over the tangential displacement U through the cycle, both engines.
    Beside it stands Q over V = U − k Q: with the elastic part taken out (k is the mean slope dU/dQ)
    the slim loop opens, and its area stays the same.

    None where neither load nor displacement moves, or the result holds no displacement. `view`
    holds the last cycles of both solutions, with U and Q (k,), and their entries of a legend.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.
    """
    comparison = view.comparison
    scene = view.scene
    cycles = (view.reference_cycle, view.result_cycle)
    displacements_u = [cycle.tangential_displacement for cycle in cycles]
    loop_series = [view.result_cycle.tangential_load, *displacements_u]
    nothing_moves = all(np.ptp(values) == 0 for values in loop_series)
    if "tangential_displacement" in reason_by_missing_field(comparison.result) or nothing_moves:
        return None

    table = {
        "time": view.result_cycle.time,
        "Q": view.result_cycle.tangential_load,
        "U_reference": displacements_u[0],
        "U_result": displacements_u[1],
    }
    _, unit_of_length, _ = units(scene)
    # A varying P does work too, where the normal approach depends on Q.
    has_constant_p = np.ptp(view.result_cycle.normal_load) == 0 and view.result_cycle.tilt is None
    # The arguments after `view.keys` fill the caption: k of each engine, works, datum of U;
    # `alone`: whether the area of the loop alone is the friction work.
    # `signed`: as text, to four digits
    return figure_with_texts(
        "hysteresis",
        _panels_of_loops(view),
        table,
        view.keys,
        stretch=view.part_of_path,
        slopes=" and ".join(signed(loop_compliance(cycle)) for cycle in cycles),
        unit=f"{unit_of_length} per {load_unit(scene)}",
        periodic=scene.load.path().period is not None,
        alone=are_half_planes(scene) or has_constant_p,
        works=_works_in_words(comparison),
        datum=_datum_in_words(comparison),
    )


def _panels_of_loops(view: CycleView) -> list[Panel]:
    """Panels of the loops through the cycle by both engines: Q over the tangential displacement U,
    and Q over V = U − k Q, k the mean slope dU/dQ. Under bulk stress a third has the moment of the
    shear over the bulk strain: the friction work is not the area of one loop alone then.

    `view` holds the last cycles of both solutions.
    """
    cycles = (view.reference_cycle, view.result_cycle)
    _, unit_of_length, _ = units(view.scene)
    panels = [
        _loop_panel(
            view,
            "hysteresis",
            ("U", [cycle.tangential_displacement for cycle in cycles]),
            f"tangential displacement U  [{unit_of_length}]",
        ),
        _loop_panel(
            view,
            "hysteresis-sheared",
            ("V", [sheared_displacement(cycle) for cycle in cycles]),
            f"U − k Q, about its mean  [{unit_of_length}]",
        ),
    ]
    has_moments = all(cycle.shear_moment is not None for cycle in cycles)
    if view.comparison.has_bulk_stress and has_moments:
        panels.append(_bulk_loop_panel(view))
    return panels


def _datum_in_words(comparison: JudgedPair) -> str:
    """In words, what the displacement U of half-planes means beside that of finite bodies: with the
    compliances of these bodies, or counted from another point; "" where there is nothing to add.
    """
    if comparison.effects is not None:
        return "that of half-planes with c_t, c_n of these bodies"
    if comparison.lacks_common_datum:
        return "no datum: that of half-planes counts from another place than that of these bodies"
    return ""


def _loop_panel(
    view: CycleView,
    name: str,
    letter_and_displacements: tuple[str, list[Array]],
    words_of_displacement: str,
) -> Panel:
    """A panel of the tangential load Q over a displacement through the cycle, a loop for each
    engine.

    `css` is a class of the style sheet.

    Parameters
    ----------
    view
        last cycles of reference and result, their legend entries (`keys`), the instants that have a
        number in figures, and the index of that shown first
    name
        of the panel on the page
    letter_and_displacements
        letter of the displacement, U or V = U − k Q (without its elastic part); and its values in
        the reference and in the result, (k,) each
    words_of_displacement
        words of its axis, with the unit
    """
    letter, displacements = letter_and_displacements
    loads = [view.reference_cycle.tangential_load, view.result_cycle.tangential_load]
    marks: list[Mark] = []
    for key, displacement, load in zip(view.keys, displacements, loads, strict=True):
        marks.append(Curve(displacement, load, key.css, key.text))
    note = _difference_of_loops_in_words(view, letter, displacements)
    # _LOOP_HEIGHT: 220 pixels
    panel = Panel(
        name,
        Axis(*axis_limits(*displacements, margin=0.12), words_of_displacement, n_ticks=4),
        Axis(*axis_limits(*loads, margin=0.12), f"tangential load Q  [{load_unit(view.scene)}]"),
        marks,
        f"Tangential load over {words_of_displacement}",
        height=_LOOP_HEIGHT,
        notes=[note] if note else [],
    )
    marks += _numbered_dots(panel, displacements[1], loads[1], view.chosen_events)
    # rings that the page's slider moves along the loops: "U0" over "Q0" of the reference, "U1" over
    # "Q" of the result
    shown_instant = view.shown_instant
    for engine_number, (y_series, css) in enumerate((("Q0", "now pale"), ("Q", "now"))):
        shown_displacement = displacements[engine_number][shown_instant]
        shown_load = loads[engine_number][shown_instant]
        marks.append(
            _slider_ring(f"{letter}{engine_number}", shown_displacement, y_series, shown_load, css)
        )
    return panel


def _difference_of_loops_in_words(
    view: CycleView, letter: str, displacements: Sequence[Array]
) -> str:
    """The difference of a displacement between two loops, in words: root mean square and largest
    value, in per cent of the range in the reference.

    `displacements` are those of the reference and of the result, (k,) each; `letter` is "U", or "V"
    for the displacement without its elastic part. "" for U that the engines count from two
    different points. `view` holds the comparison and the last cycles of both solutions.
    """
    if letter == "U" and view.comparison.lacks_common_datum:
        return ""
    reference_values, result_values = displacements
    range_of_displacement = float(np.ptp(reference_values)) or 1.0
    difference_in_percent = 100 * (result_values - reference_values) / range_of_displacement
    fraction = view.result_cycle.fraction  # of the period, (k,)
    # " at ...", the place of the largest value, is left out
    numbers_and_place = difference_in_words(difference_in_percent, fraction, "{}", " %")
    numbers_in_words = numbers_and_place.rpartition(" at ")[0]
    if not numbers_in_words:
        return ""
    loop_extent = "stroke" if letter == "U" else "width"
    return f"{numbers_in_words}, of the {loop_extent}"


def _works_in_words(comparison: JudgedPair) -> tuple[str, ...]:
    """For the caption of the loop of Q over U under bulk stress, four texts: its area, the work of
    the bulk stress and the friction work W, each as "reference and result"; and their unit, per
    thickness. Empty without bulk stress.
    """
    if not comparison.has_bulk_stress:
        return ()
    scene = comparison.scene
    cycles = (comparison.reference_cycle, comparison.result_cycle)
    works = (
        [loop_work(cycle) for cycle in cycles],
        [bulk_work(cycle, scene.material) for cycle in cycles],
        [comparison.reference.dissipation, comparison.result.dissipation],
    )
    # `minus`: with a real minus sign
    works_in_words = [
        f"{minus(f'{work_of_reference:.5g}')} and {minus(f'{work_of_result:.5g}')}"
        for work_of_reference, work_of_result in works
    ]
    return (*works_in_words, energy_unit(scene))


def _bulk_loop_panel(view: CycleView) -> Panel:
    """A panel of the moment of the shear traction about x = 0 over the bulk strain, both engines.
    The area of this loop is the work of the bulk stress. `view` holds the last cycles of both
    solutions, with the moment (k,), and their entries of a legend.

    `css` is a class of the style sheet.
    """
    # words for the units of the scene: force, length, stress
    unit_of_force, _, _ = units(view.scene)
    cycles = (view.reference_cycle, view.result_cycle)
    strains = [bulk_strain(cycle, view.scene.material) for cycle in cycles]
    moments = [np.asarray(cycle.shear_moment) for cycle in cycles]
    marks: list[Mark] = []
    for key, strain, moment in zip(view.keys, strains, moments, strict=True):
        marks.append(Curve(strain, moment, key.css, key.text))
    return Panel(
        "bulk-loop",
        Axis(*axis_limits(*strains, margin=0.12), "bulk strain ε = σ/E′, lower − upper", n_ticks=4),
        Axis(*axis_limits(*moments, margin=0.12), f"moment of the shear m_q  [{unit_of_force}]"),
        marks,
        "Moment of the shear over bulk strain",
        height=_LOOP_HEIGHT,
    )
