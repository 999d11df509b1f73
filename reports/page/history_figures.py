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
    figure_with_texts,
    limits,
)
from reports.charts.templating import Table
from reports.comparison.cycles import Cycle, Event
from reports.comparison.judged import JudgedPair
from reports.comparison.metrics import missing
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
from scenes import Scene, sampled
from scenes.array_types import Array
from scenes.scene import OWN_TOLERANCES

_MOST_TOLERANCES = 8.0  # that an axis of discrepancies holds
# Of load path and loops, which stand one under the other beside the tractions [units of a
# drawing].
_LOOP_HEIGHT = 220.0


def half_widths(view: CycleView) -> Plate:
    """A figure of the contact edges and stick edges of both engines through the cycle, and beside
    it the difference of the half-widths, result minus reference, per cent of a_ref. `view` holds
    the last cycles of both solutions.
    """
    half_width = view.scales.half_width
    curves: list[Curve] = []
    keys: list[Key] = []
    table = {"time": view.result_cycle.time}
    half_widths_of: dict[str, list[Array]] = {"contact": [], "stick": []}
    for role, engine in zip(("reference", "result"), view.engines, strict=True):
        for kind, css in (("contact", "p"), ("stick", "q")):
            edges = getattr(engine.cycle, f"{kind}_edges")
            left_edge, right_edge = edges.T
            key = Key(f"{engine.look} {css}", f"{kind} edge, {engine.name}")
            keys.append(key)
            curves.append(Curve(view.time, left_edge / half_width, key.css, key.text))
            curves.append(Curve(view.time, right_edge / half_width, key.css, key.text))
            half_widths_of[kind].append((right_edge - left_edge) / 2 / half_width)
            table[f"left_{kind}_edges_{role}"] = left_edge
            table[f"right_{kind}_edges_{role}"] = right_edge
    upper_panel = Panel(
        "edges",
        view.over_time(),
        Axis(*limits(*(line.y for line in curves)), X_OVER_A),
        curves,
        f"Contact and stick edges through the {view.noun}",
        time="x",
    )

    differences = {
        kind: 100 * (result_values - reference_values)
        for kind, (reference_values, result_values) in half_widths_of.items()
    }
    notes = [
        f"{kind}: {view.difference_over_time(difference, ' % of a_ref')}"
        for kind, difference in differences.items()
    ]
    difference_axis = Axis(
        *limits(*differences.values(), with_zero=True, least_range=1e-10),
        "difference, % of a_ref",
    )
    lower_panel = Panel(
        "edges-difference",
        view.over_time(),
        difference_axis,
        [
            ZERO,
            Curve(view.time, differences["contact"], "d p", "contact"),
            Curve(view.time, differences["stick"], "d q", "stick"),
        ],
        "Difference of the half-widths",
        notes=notes,
        time="x",
    )
    spacing = _spacing_at_the_edge(view.result_cycle) / half_width
    legend = (*keys, Key("d p", "difference, contact"), Key("d q", "difference, stick"))
    return figure_with_texts(
        "half_widths",
        (upper_panel, lower_panel),
        table,
        legend,
        stretch=view.stretch,
        spacing=f"{spacing:.1g}" if np.isfinite(spacing) else "",
    )


def _spacing_at_the_edge(cycle: Cycle) -> float:
    """The middle distance of points about the contact edges [length]; NaN where nothing
    touches.
    """
    outer_edge = float(np.nanmax(np.abs(cycle.contact_edges), initial=0.0))
    if not outer_edge:
        return math.nan
    about_the_edge = np.abs(np.abs(cycle.x[1:]) - outer_edge) < 0.3 * outer_edge
    return float(np.median(np.diff(cycle.x)[about_the_edge]))


def discrepancies(view: CycleView) -> Plate:
    """A figure of the differences through the cycle: of each metric with a tolerance the absolute
    difference at each instant, over its tolerance.

    Where no metric has a tolerance it shows, in per cent, those that comparisons between
    half-planes are judged by. `view` holds the last cycles of both solutions.
    """
    metrics = [metric for metric in view.comparison.metrics if metric.series is not None]
    metrics_with_tolerance = [metric for metric in metrics if metric.tolerance is not None]
    is_judged = bool(metrics_with_tolerance)
    drawn_metrics = metrics_with_tolerance or [
        metric for metric in metrics if metric.key in OWN_TOLERANCES
    ]
    marks: list[Mark] = []
    if is_judged:
        marks.append(Rule(1.0, "limit"))
    keys = []
    largest_ratio = 0.0
    for metric, css in zip(drawn_metrics, LINE_LOOKS, strict=False):
        unit_of_ratio = (metric.tolerance or 1.0) if is_judged else 0.01
        ratios = np.abs(np.asarray(metric.series)) / unit_of_ratio
        # At a light load errors relative to the small traction measure the mesh only.
        judged_ratios = np.where(view.comparison.is_judged, ratios, np.nan)
        worst_instant = int(np.nanargmax(judged_ratios)) if np.isfinite(judged_ratios).any() else 0
        largest_ratio = max(largest_ratio, float(np.nanmax(judged_ratios, initial=0.0)))
        marks.append(Curve(view.time, judged_ratios, css, metric.label))
        per_cent = "" if is_judged else " %"
        text = (
            f"{metric.label}: {judged_ratios[worst_instant]:.2g}{per_cent} at"
            f" {view.time[worst_instant]:.3g}"
        )
        keys.append(Key(css, minus(text)))
    if is_judged:
        last_time = float(view.time[-1])
        marks.append(Note(last_time, 1.0, "tolerance", anchor="end", shift=(-4.0, -5.0)))
    if is_judged:
        largest_drawn = min(max(1.0, largest_ratio), _MOST_TOLERANCES)
        axis_words = "|discrepancy| / tolerance"
    else:
        largest_drawn = largest_ratio or 1.0
        axis_words = "|discrepancy|, %"
    panel = broad_panel(
        "errors",
        view.over_time(8),
        Axis(0.0, 1.08 * largest_drawn, axis_words),
        marks,
        f"Discrepancy through the {view.noun}",
        time="x",
    )
    table = {"time": view.result_cycle.time}
    table |= {metric.key: np.asarray(metric.series) for metric in drawn_metrics}
    return figure_with_texts(
        "errors",
        [panel],
        table,
        keys,
        columns=1,
        judged=is_judged,
        cut=is_judged and largest_ratio > _MOST_TOLERANCES,
        stretch=view.stretch,
    )


def slip_histories(view: CycleView) -> Plate:
    """A figure of the slip of a few points through the cycle, both engines, counted from where each
    point stood at its start. `view` holds the last cycles of both solutions.
    """
    points = slip_points(view.comparison)
    unit_of_length = units(view.scene)[1]
    names = [f"x = {view.x[point]:.3f} a_ref" for point in points]
    slips = [engine.cycle.slip[:, points] - engine.cycle.slip[0, points] for engine in view.engines]
    curves = []
    for look, slip_of_engine, engine in zip(("wide", "thin"), slips, view.engines, strict=True):
        for number, name in enumerate(names):
            css = f"{look} point-{number}"
            curves.append(
                Curve(view.time, slip_of_engine[:, number], css, f"{name}, {engine.name}")
            )
    reference_values, result_values = slips
    table = {"time": view.result_cycle.time}
    for number, point in enumerate(points):
        place_in_words = f"(x = {view.result_cycle.x[point]:.6g}) [{unit_of_length}]"
        table[f"slip_reference{place_in_words}"] = reference_values[:, number]
        table[f"slip_result{place_in_words}"] = result_values[:, number]

    difference = result_values - reference_values
    worst_point = int(np.argmax(np.nanmax(np.abs(np.nan_to_num(difference)), axis=0)))
    notes = [
        f"result − reference at {names[worst_point]}, where it is largest:",
        view.difference_over_time(difference[:, worst_point], f" {unit_of_length}"),
    ]
    least_slip = 1e-12 * view.scales.half_width
    panel = broad_panel(
        "slip",
        view.over_time(8),
        Axis(
            *limits(*slips, with_zero=True, least_range=least_slip),
            f"slip since the start  [{unit_of_length}]",
        ),
        curves,
        "Slip of chosen points over time",
        320.0,
        notes=notes,
        time="x",
    )
    keys = [Key(f"point-{number}", name) for number, name in enumerate(names)]
    return figure_with_texts("slip_history", [panel], table, keys, columns=1, stretch=view.stretch)


def cumulative_work(view: CycleView) -> Plate | None:
    """A figure of the friction work so far through a measured record of loads, by both engines;
    None for other loads. `view` holds the last cycles of both solutions.
    """
    solutions = (view.comparison.reference, view.comparison.result)
    series = []
    for key, solution in zip(view.keys, solutions, strict=True):
        cycles = load_cycles(solution)
        if cycles is not None:
            series.append((key, cycles.time, cycles.cumulative))
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
        Axis(*limits(every_time, margin=0.02), "time"),
        Axis(*limits(*(work for *_, work in series), with_zero=True), f"W so far  [{unit}]"),
        curves,
        "Dissipation so far over time",
        260.0,
    )
    return figure_with_texts(
        "cumulative_work",
        [panel],
        table,
        [key for key, *_ in series],
        columns=1,
        repeats=view.scene.load.path().period is not None,
    )


def load_path(view: CycleView) -> Plate:
    """A figure of the load path in the P-Q plane: initial loading, cycle, Coulomb limit, dots with
    numbers at chosen instants, and a ring at the instant that the page shows first.

    Beneath it stand bulk stress, tilt and moment over the cycle, where the scene has them. `view`
    holds the last cycles of both solutions.
    """
    cycle = view.result_cycle
    friction = view.comparison.result.scene.friction.coefficient
    unit = load_unit(view.comparison.result.scene)
    parts = _parts_of_path(view.comparison.result.scene)
    normal_load = np.concatenate([part.normal_load for part in parts])
    tangential_load = np.concatenate([part.tangential_load for part in parts])
    largest_normal = 1.08 * float(normal_load.max())
    largest_tangential = 1.25 * max(float(np.abs(tangential_load).max()), 0.15 * largest_normal)

    marks: list[Mark] = []
    if friction:
        for sign in (1, -1):
            limit = sign * largest_normal * friction
            marks.append(Curve([0, largest_normal], [0, limit], "cone", "|Q| = f P"))
    marks += [Curve(part.normal_load, part.tangential_load, part.look, part.name) for part in parts]
    lowest_load = min(-0.3 * largest_tangential, 1.25 * float(tangential_load.min()))
    panel = Panel(
        "load-path",
        Axis(0.0, largest_normal, f"normal load P  [{unit}]"),
        Axis(lowest_load, largest_tangential, f"tangential load Q  [{unit}]"),
        marks,
        "Load path in the plane of P and Q",
        height=_LOOP_HEIGHT,
    )
    marks += _events(panel, cycle.normal_load, cycle.tangential_load, view.chosen_events)
    instant_shown = view.shown_instant
    marks.append(
        _follower(
            "P", cycle.normal_load[instant_shown], cycle.tangential_load[instant_shown], "now"
        )
    )

    keys = [Key(part.look, part.name) for part in reversed(parts)]
    if friction:
        keys.append(Key("cone", "|Q| = f P"))
    panels = [panel]
    for name, title, lines_of_panel in _beside_the_forces(view):
        panels.append(_panel_beneath_path(view, name, title, lines_of_panel))
        keys += [Key(line.css, line.text) for line in lines_of_panel]
    table: Table = {
        "time": np.concatenate([part.time for part in parts]),
        "part": [part.name for part in parts for _ in part.time],
        "P": normal_load,
        "Q": tangential_load,
    }
    has_bulk_or_tilt = len(panels) > 1
    return figure_with_texts(
        "load_path", panels, table, keys, columns=1, beside=has_bulk_or_tilt, stretch=view.stretch
    )


def _panel_beneath_path(view: CycleView, name: str, title: str, lines: Sequence[_Line]) -> Panel:
    """A low panel of some series over time (bulk stress, tilt or moment), beneath the load path;
    `title` is the title of its vertical axis. `view` holds the last cycles of both solutions.
    """
    curves: list[Mark] = [ZERO]
    curves += [Curve(view.time, line.values, line.css, line.text) for line in lines]
    series = [line.values for line in lines]
    return Panel(
        name,
        view.over_time(),
        Axis(*limits(*series, with_zero=True, margin=0.12), title, count=3),
        curves,
        f"{title} over time",
        height=190.0,
        time="x",
    )


class _PathPart(NamedTuple):
    """Initial loading or cycle of a load path, at many instants."""

    name: str
    look: str  # of its line
    time: Array
    normal_load: Array
    tangential_load: Array


def _parts_of_path(scene: Scene) -> list[_PathPart]:
    """Initial loading and cycle of a scene's load path, each as P and Q at many instants; one part
    where nothing repeats.
    """
    path = scene.load.path()
    named_parts = [("path", "loop", path.initial_loading)]
    if path.cycle:
        named_parts = [
            ("initial loading", "initial-loading", path.initial_loading),
            ("cycle", "loop", path.cycle),
        ]
    parts = []
    for name, look, segments in named_parts:
        if segments:
            time = np.concatenate([sampled(segment, 257) for segment in segments])
            normal_load, tangential_load = path.at(time)
            parts.append(
                _PathPart(name, look, time, np.asarray(normal_load), np.asarray(tangential_load))
            )
    return parts


class _Line(NamedTuple):
    """A line of a figure over time."""

    css: str
    text: str
    values: Array


def _beside_the_forces(view: CycleView) -> Iterator[tuple[str, str, list[_Line]]]:
    """What acts beside P and Q over the cycle: for bulk stress, tilt and moment, as far as the
    scene has them, the name of a panel, the title of its axis with the unit, and its lines over
    time. `view` holds the last cycles of both solutions.
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
    if cycle.moment is not None and np.any(cycle.moment) and view.scene.load.moment_given:
        yield (
            "moment",
            f"moment M  [{unit_of_force}]",
            [_Line("line-3 fine", "moment", cycle.moment)],
        )


def _events(
    panel: Panel, x_values: Array, y_values: Array, events: Sequence[Event]
) -> Iterator[Mark]:
    """Dots on a closed loop at chosen instants, with numbers that stand outside the loop. A number
    that would lie on another one is left out.

    Parameters
    ----------
    panel
        in which the loop is drawn
    x_values, y_values
        (k,) coordinates of the loop at all instants
    events
        the chosen instants, in the order of their numbers
    """
    x = panel.frame.x.place(x_values)
    y = panel.frame.y.place(y_values)
    number_places: list[Array] = []  # places of those that are drawn
    for event_number, event in enumerate(events, start=1):
        instant = event.index
        event_data = {"event": instant}
        dot_place = np.array([x[instant], y[instant]])
        shift = _within(13 * _outward(x, y, instant), dot_place, panel.frame.box)
        place = dot_place + shift
        yield Dot(float(x_values[instant]), float(y_values[instant]), "event", 3.4, data=event_data)
        if all(np.hypot(*(place - number)) > 11 for number in number_places):
            number_places.append(place)
            yield Note(
                float(x_values[instant]),
                float(y_values[instant]),
                str(event_number),
                "number",
                "middle",
                (float(shift[0]), float(shift[1]) + 4),
                event_data,
            )


def _outward(x: Array, y: Array, place: int) -> Array:
    """Unit vector across a line at the place of this index, pointing away from the middle of the
    line. `x`, `y` are the coordinates of its places, (n,) each.
    """
    place_before = max(place - 1, 0)
    place_after = min(place + 1, len(x) - 1)
    normal_direction = np.array(
        [y[place_before] - y[place_after], x[place_after] - x[place_before]]
    )
    vector_from_middle = np.array([x[place] - x.mean(), y[place] - y.mean()])
    if not np.all(np.isfinite(normal_direction)) or not np.hypot(*normal_direction):
        normal_direction = vector_from_middle
    if normal_direction @ vector_from_middle < 0:
        normal_direction = -normal_direction
    return np.asarray(normal_direction / (np.hypot(*normal_direction) or 1.0))


# Half the width and half the height of a number [units of a drawing].
_HALF_NUMBER = np.array([5.0, 7.0])


def _within(shift: Array, dot_place: Array, box: tuple[float, float, float, float]) -> Array:
    """Change the shift of a number from its dot so that the number stays in the box.

    Parameters
    ----------
    shift
        (2,) wanted distance of the number from the dot [pixels]; it is mirrored, or else shortened
    dot_place
        (2,) place of the dot
    box
        left, top, right and bottom end of the box
    """
    left_x, top_y, right_x, bottom_y = box
    lower_corner = np.array([left_x, top_y]) + _HALF_NUMBER
    upper_corner = np.array([right_x, bottom_y]) - _HALF_NUMBER
    for sign in ([1, 1], [1, -1], [-1, 1], [-1, -1]):
        number_place = dot_place + sign * shift
        if np.all((lower_corner <= number_place) & (number_place <= upper_corner)):
            return np.asarray(sign * shift)
    return np.asarray(np.clip(dot_place + shift, lower_corner, upper_corner) - dot_place)


def _follower(x: str, x_values: float, y_values: float, css: str) -> Dot:
    """A ring that the slider moves along Q over another series."""
    return Dot(
        float(x_values),
        float(y_values),
        f"follow {css}",
        6.5,
        data={"series_x": x, "series_y": "Q"},
    )


def hysteresis(view: CycleView) -> Plate | None:
    """A figure of the loop of Q over the tangential displacement U through the cycle, both engines;
    and beside it Q over V = U - k Q, whose loop is wide open, k being the compliance of the loop.

    None where neither load nor displacement moves, or the result holds no displacement. `view`
    holds the last cycles of both solutions.
    """
    comparison = view.comparison
    scene = view.scene
    cycles = (view.reference_cycle, view.result_cycle)
    displacements_u = [cycle.tangential_displacement for cycle in cycles]
    loop_series = [view.result_cycle.tangential_load, *displacements_u]
    nothing_moves = all(np.ptp(values) == 0 for values in loop_series)
    if "tangential_displacement" in missing(comparison.result) or nothing_moves:
        return None

    _, unit_of_length, _ = units(scene)
    displacements_v = [sheared_displacement(cycle) for cycle in cycles]
    panels = [
        _loop_panel(
            view,
            "hysteresis",
            ("U", displacements_u),
            f"tangential displacement U  [{unit_of_length}]",
        ),
        _loop_panel(
            view,
            "hysteresis-sheared",
            ("V", displacements_v),
            f"U − k Q, about its mean  [{unit_of_length}]",
        ),
    ]
    # With bulk stress the friction work is not the area of one loop alone.
    if comparison.has_bulk_stress and all(cycle.shear_moment is not None for cycle in cycles):
        panels.append(_bulk_loop_panel(view))

    table = {
        "time": view.result_cycle.time,
        "Q": view.result_cycle.tangential_load,
        "U_reference": displacements_u[0],
        "U_result": displacements_u[1],
    }
    # P works too where it varies and the approach hangs on Q as well.
    constant_load = np.ptp(view.result_cycle.normal_load) == 0 and view.result_cycle.tilt is None
    return figure_with_texts(
        "hysteresis",
        panels,
        table,
        view.keys,
        stretch=view.stretch,
        slopes=" and ".join(signed(loop_compliance(cycle)) for cycle in cycles),
        unit=f"{unit_of_length} per {load_unit(scene)}",
        periodic=scene.load.path().period is not None,
        alone=are_half_planes(scene) or constant_load,
        works=_works_in_words(comparison),
        datum=_datum_in_words(comparison),
    )


def _datum_in_words(comparison: JudgedPair) -> str:
    """In words, which place the displacement U of half-planes is counted from, beside finite
    bodies; "" where there is nothing to say.
    """
    if comparison.effects is not None:
        return "that of half-planes with c_t, c_n of these bodies"
    if comparison.lacks_common_datum:
        return "no datum: that of half-planes counts from another place than that of these bodies"
    return ""


def _loop_panel(
    view: CycleView, name: str, displacement: tuple[str, list[Array]], title: str
) -> Panel:
    """A panel of the tangential load Q over a displacement through the cycle, a loop for each
    engine.

    Parameters
    ----------
    view
        last cycles of reference and result, and the instants that figures number
    displacement
        letter of the displacement, U or V = U − k Q, by which the slider moves a dot; its values in
        the reference and in the result, (k,) each
    title
        words of the axis
    """
    letter, (reference_values, result_values) = displacement
    loads = [view.reference_cycle.tangential_load, view.result_cycle.tangential_load]
    range_of_displacement = float(np.ptp(reference_values)) or 1.0
    difference_in_percent = 100 * (result_values - reference_values) / range_of_displacement
    fraction = view.result_cycle.fraction
    numbers_and_place = difference_in_words(difference_in_percent, fraction, "{}", " %")
    difference_note = numbers_and_place.rpartition(" at ")[0]
    if letter == "U" and view.comparison.lacks_common_datum:
        difference_note = ""  # the distance of two places from which U is counted
    loop_extent = "stroke" if letter == "U" else "width"
    marks: list[Mark] = []
    for key, values, loads_of_engine in zip(
        view.keys, (reference_values, result_values), loads, strict=True
    ):
        marks.append(Curve(values, loads_of_engine, key.css, key.text))
    panel = Panel(
        name,
        Axis(*limits(reference_values, result_values, margin=0.12), title, count=4),
        Axis(*limits(*loads, margin=0.12), f"tangential load Q  [{load_unit(view.scene)}]"),
        marks,
        f"Tangential load over {title}",
        height=_LOOP_HEIGHT,
        notes=[f"{difference_note}, of the {loop_extent}"] if difference_note else [],
    )
    marks += _events(panel, result_values, loads[1], view.chosen_events)
    instant_shown = view.shown_instant
    marks.append(
        _follower(
            f"{letter}0", reference_values[instant_shown], loads[0][instant_shown], "now pale"
        )
    )
    marks.append(
        _follower(f"{letter}1", result_values[instant_shown], loads[1][instant_shown], "now")
    )
    return panel


def _works_in_words(comparison: JudgedPair) -> tuple[str, ...]:
    """For the caption of the loop of Q over U under bulk stress: its area, the work of the bulk
    stress and the friction work W, each "reference and result"; and their unit. Empty without bulk
    stress.
    """
    if not comparison.has_bulk_stress:
        return ()
    scene = comparison.scene
    cycles = (comparison.reference_cycle, comparison.result_cycle)
    works_of_cycle = (
        [loop_work(cycle) for cycle in cycles],
        [bulk_work(cycle, scene.material) for cycle in cycles],
        [comparison.reference.dissipation, comparison.result.dissipation],
    )
    works_in_words = [
        f"{minus(f'{work_of_reference:.5g}')} and {minus(f'{work_of_result:.5g}')}"
        for work_of_reference, work_of_result in works_of_cycle
    ]
    return (*works_in_words, energy_unit(scene))


def _bulk_loop_panel(view: CycleView) -> Panel:
    """A panel of the moment of the shear over the bulk strain, both engines: the area of this loop
    is the work of the bulk stress. `view` holds the last cycles of both solutions.
    """
    unit_of_force, _, _ = units(view.scene)
    cycles = (view.reference_cycle, view.result_cycle)
    strains = [bulk_strain(cycle, view.scene.material) for cycle in cycles]
    moments = [np.asarray(cycle.shear_moment) for cycle in cycles]
    marks: list[Mark] = []
    for key, strain, moment in zip(view.keys, strains, moments, strict=True):
        marks.append(Curve(strain, moment, key.css, key.text))
    return Panel(
        "bulk-loop",
        Axis(*limits(*strains, margin=0.12), "bulk strain ε = σ/E′, lower − upper", count=4),
        Axis(*limits(*moments, margin=0.12), f"moment of the shear m_q  [{unit_of_force}]"),
        marks,
        "Moment of the shear over bulk strain",
        height=_LOOP_HEIGHT,
    )
