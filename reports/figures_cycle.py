"""Figures through time and in the plane of the loads: edges, errors, slip of chosen points, load path, hysteresis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from reports.charts import marks
from reports.charts.panel import Axis, frame, panel
from reports.charts.plate import Key, Plate
from reports.charts.scale import limits
from reports.comparison import Comparison
from reports.definitions import name_of
from reports.instants import Event
from reports.missing import missing
from reports.sampling import Cycle
from reports.units import load_unit, units
from reports.verdicts import Metric
from scenes import ContactSolution, StraightLeg

Array = NDArray[np.float64]
LINES = tuple(f"line-{k}" for k in range(7))


def half_widths(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Contact and stick edges of both engines through the last cycle, the difference of the half-widths beside them."""
    length = comparison.scales.half_width
    cycles = (("r", comparison.expected, comparison.reference), ("f", comparison.found, comparison.result))
    edges = (("contact_edges", "p", "contact edge"), ("stick_edges", "q", "stick edge"))
    shown = [getattr(cycle, name) / length for _, cycle, _ in cycles for name, _, _ in edges]
    axes = Axis(*limits(time, margin=0), time_words), Axis(*limits(*shown), "x / a_ref")
    area = frame(*axes)
    lines = [
        marks.curve(area, time, getattr(cycle, name)[:, side] / length, f"{who} {what}", f"{label}, {name_of(solution.engine)}")
        for who, cycle, solution in cycles
        for name, what, label in edges
        for side in (0, 1)
    ]
    apart = {
        label: (_half(comparison.found, name) - _half(comparison.expected, name)) / length
        for name, label in (("contact_edges", "contact"), ("stick_edges", "stick"))
    }
    differences = axes[0], Axis(*limits(*apart.values(), zero=True, least=1e-12), "difference of half-widths / a_ref")
    beside = frame(*differences)
    below = [
        marks.horizontal(beside, 0.0, "zero"),
        *(marks.curve(beside, time, apart[k], f"d {css}", k) for k, css in (("contact", "p"), ("stick", "q"))),
    ]
    title = "Contact and stick edges through the cycle"
    return Plate(
        "half_widths",
        title,
        "Left: where contact and stick end. Right: half the distance between the edges, result less reference. In full stick "
        "the stick edges are the contact edges; in full slip there are none.",
        "Contact and stick edges over time for both engines, and the difference of the half-widths.",
        (
            panel(area, *axes, lines, title, clip="edges", time="x"),
            panel(beside, *differences, below, "Difference of the half-widths", clip="edges-difference", time="x"),
        ),
        {
            "time": comparison.found.time,
            **{
                f"{side}_{name}_{who}": getattr(cycle, name)[:, column]
                for who, cycle in (("reference", comparison.expected), ("result", comparison.found))
                for name in ("contact_edges", "stick_edges")
                for column, side in enumerate(("left", "right"))
            },
        },
        (
            *(Key(f"{who} {css}", f"{label}, {name_of(s.engine)}") for who, _, s in cycles for _, css, label in edges),
            Key("d p", "difference, contact"),
            Key("d q", "difference, stick"),
        ),
    )


def _half(cycle: Cycle, edges: str) -> Array:
    pair = getattr(cycle, edges)
    return np.asarray((pair[:, 1] - pair[:, 0]) / 2)


def errors(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Every metric that has a tolerance and a value at each instant, over its tolerance, at the instants that are judged."""
    shown = [m for m in comparison.metrics if m.series is not None and m.tolerance is not None]
    largest = max((_largest(m, comparison) for m in shown), default=1.0)
    axes = (
        Axis(*limits(time, margin=0), time_words, count=8),
        Axis(0.0, 1.08 * min(max(1.0, largest), 8.0), "|discrepancy| / tolerance"),
    )
    area = frame(*axes, width=900.0, height=280.0)
    lines = [marks.horizontal(area, 1.0, "limit")]
    for metric, css in zip(shown, LINES * 3, strict=False):
        size = np.where(comparison.judged, np.abs(np.asarray(metric.series)) / (metric.tolerance or 1.0), np.nan)
        lines.append(marks.curve(area, time, size, css, metric.label))
    lines.append(marks.words(area.x.end - 4, float(area.y.place(1.0)) - 5, "tolerance", class_="tick", text_anchor="end"))
    beyond = " Curves above 8 are cut off: their values are in the CSV." if largest > 8 else ""
    return Plate(
        "errors",
        "Discrepancy through the cycle",
        f"Each metric over its own tolerance, at the instants that are judged: above 1 it fails.{beyond}",
        "Discrepancies over their tolerances through the last cycle.",
        (panel(area, *axes, lines, "Discrepancy over tolerance through the cycle", clip="errors", time="x", css="broad"),),
        {"time": comparison.found.time} | {m.key: np.asarray(m.series) for m in shown},
        tuple(Key(css, metric.label) for metric, css in zip(shown, LINES * 3, strict=False)),
        columns=1,
    )


def _largest(metric: Metric, comparison: Comparison) -> float:
    """The largest |value| of a metric at the instants that are judged, over its tolerance."""
    judged = np.abs(np.asarray(metric.series))[comparison.judged]
    return float(np.nanmax(judged, initial=0.0)) / (metric.tolerance or 1.0)


def load_path(solution: ContactSolution, cycle: Cycle, chosen: Sequence[Event]) -> Plate:
    """The path in the P-Q plane: way in, cycle, friction cone, chosen instants."""
    time, part, normal, tangential = _path(solution)
    cone = (Key("cone", "|Q| = f P"),) if solution.scene.friction.coefficient else ()
    return Plate(
        "load_path",
        "Load path",
        "The numbers are the chosen instants, in the order of time; the ring is the instant shown.",
        "Path of the loads in the plane of P and Q with the friction cone.",
        (load_panel(solution, cycle, chosen, "load-path", 330.0),),
        {"time": time, "part": [str(p) for p in part], "P": normal, "Q": tangential},
        (Key("loop", "cycle"), Key("way-in", "way in"), *cone),
        columns=1,
    )


def load_panel(solution: ContactSolution, cycle: Cycle, chosen: Sequence[Event], clip: str, height: float) -> str:
    """The drawing of the load path, `height` units high, with a ring at the first chosen instant."""
    friction = solution.scene.friction.coefficient
    _, part, normal, tangential = _path(solution)
    top = 1.08 * float(normal.max())
    reach = 1.25 * max(float(np.abs(tangential).max()), 0.15 * top)
    unit = load_unit(solution.scene)
    axes = (
        Axis(0.0, top, f"normal load P  [{unit}]"),
        Axis(min(-0.3 * reach, 1.25 * float(tangential.min())), reach, f"tangential load Q  [{unit}]"),
    )
    area = frame(*axes, width=440.0, height=height)
    lines = [marks.curve(area, [0, top], [0, s * friction * top], "cone", "|Q| = f P") for s in (1, -1) if friction]
    for name, css in (("way in", "way-in"), ("cycle", "loop")):
        if (part == name).any():
            lines.append(marks.curve(area, normal[part == name], tangential[part == name], css, name))
    lines += _events(area, cycle.normal_load, cycle.tangential_load, chosen)
    start = chosen[0].index
    lines.append(_follower(area, "P", "Q", cycle.normal_load[start], cycle.tangential_load[start], "now"))
    return panel(area, *axes, lines, "Load path in the plane of P and Q", clip=clip)


def _path(solution: ContactSolution) -> tuple[Array, NDArray[np.str_], Array, Array]:
    """Times, the part they belong to, P and Q all along the path."""
    path = solution.scene.load.path()
    legs = [(leg, "way in") for leg in path.way_in] + [(leg, "cycle") for leg in path.cycle]
    samples = [(np.linspace(leg.start, leg.end, 2 if isinstance(leg, StraightLeg) else 257), part) for leg, part in legs]
    time = np.concatenate([t for t, _ in samples])
    part = np.concatenate([np.full(len(t), name) for t, name in samples])
    normal, tangential = path.at(time)
    return time, part, np.asarray(normal), np.asarray(tangential)


def _events(area: marks.Frame, across: Array, up: Array, chosen: Sequence[Event]) -> Iterator[str]:
    """Numbered dots, numbers outside the loop that the dots lie on; a number that would stand on another one is left out."""
    x, y = area.x.place(across), area.y.place(up)
    taken: list[Array] = []
    for number, event in enumerate(chosen, start=1):
        here = np.array([x[event.index], y[event.index]])
        place = here + 13 * _outward(x, y, event.index)
        yield marks.element("circle", cx=float(here[0]), cy=float(here[1]), r=3.4, class_="event", data_event=event.index)
        if all(np.hypot(*(place - other)) > 11 for other in taken):
            taken.append(place)
            yield marks.words(place[0], place[1] + 4, str(number), class_="number", text_anchor="middle", data_event=event.index)


def _outward(x: Array, y: Array, k: int) -> Array:
    """Unit vector across the line at its k-th place, away from the middle of all places."""
    before, after = max(k - 1, 0), min(k + 1, len(x) - 1)
    across = np.array([y[before] - y[after], x[after] - x[before]])
    from_middle = np.array([x[k] - x.mean(), y[k] - y.mean()])
    if not np.all(np.isfinite(across)) or not np.hypot(*across):
        across = from_middle
    if across @ from_middle < 0:
        across = -across
    return np.asarray(across / (np.hypot(*across) or 1.0))


def _follower(area: marks.Frame, x: str, y: str, across: float, up: float, css: str) -> str:
    """A ring that the slider moves along two series."""
    return marks.dot(area, across, up, f"follow {css}", 6.5, data_series_x=x, data_series_y=y)


def moves(comparison: Comparison) -> bool:
    """Whether tangential load or shift move in the last cycle; a result that holds no shift has no loop."""
    if "rigid_shift" in missing(comparison.result):
        return False
    expected, found = comparison.expected, comparison.found
    return any(np.ptp(series) != 0 for series in (found.tangential_load, found.rigid_shift, expected.rigid_shift))


def hysteresis(comparison: Comparison, chosen: Sequence[Event]) -> Plate | None:
    """Tangential load over rigid shift in the last cycle, both engines; beside it sheared, so that the loop opens.

    None where neither load nor shift moves.
    """
    if not moves(comparison):
        return None
    load, length = load_unit(comparison.scene), units(comparison.scene)[1]
    return Plate(
        "hysteresis",
        "Hysteresis loop",
        "Left: shift of the upper body over the lower. Right: each less its own mean slope (k = "
        f"{loop_compliance(comparison.expected):.4g} and {loop_compliance(comparison.found):.4g} {length} per {load}) and mean, "
        "which leaves the area, the dissipation of the cycle, as it is.",
        "Tangential load over rigid shift for both engines, as it is and sheared so that the loop opens.",
        tuple(
            hysteresis_panel(comparison, chosen, clip, sheared=sheared)
            for clip, sheared in (("hysteresis", False), ("hysteresis-sheared", True))
        ),
        {
            "time": comparison.found.time,
            "Q": comparison.found.tangential_load,
            "U_reference": comparison.expected.rigid_shift,
            "U_result": comparison.found.rigid_shift,
        },
        tuple(Key(f"{w} p", name_of(s.engine)) for w, s in (("r", comparison.reference), ("f", comparison.result))),
    )


def hysteresis_panel(comparison: Comparison, chosen: Sequence[Event], clip: str, *, sheared: bool) -> str:
    """Q over the shift of both engines; `sheared`: over the shift less its mean slope, so that the loop opens."""
    length, series = units(comparison.scene)[1], "V" if sheared else "U"
    words = f"U − k Q, about its mean  [{length}]" if sheared else f"rigid shift U  [{length}]"
    cycles = (("r", comparison.expected, comparison.reference), ("f", comparison.found, comparison.result))
    shifts = [(sheared_shift(cycle) if sheared else cycle.rigid_shift) for _, cycle, _ in cycles]
    loads = [cycle.tangential_load for _, cycle, _ in cycles]
    axes = (
        Axis(*limits(*shifts, margin=0.12), words, count=4),
        Axis(*limits(*loads, margin=0.12), f"tangential load Q  [{load_unit(comparison.scene)}]"),
    )
    area = frame(*axes, height=320.0)
    lines = [
        marks.curve(area, shift, load, f"{who} p", name_of(solution.engine))
        for (who, _, solution), shift, load in zip(cycles, shifts, loads, strict=True)
    ]
    lines += _events(area, shifts[1], loads[1], chosen)
    start = chosen[0].index
    for number, (shift, load, css) in enumerate(zip(shifts, loads, ("now pale", "now"), strict=True)):
        lines.append(_follower(area, f"{series}{number}", "Q", shift[start], load[start], css))
    return panel(area, *axes, lines, f"Tangential load over {words}", clip=clip)


def sheared_shift(cycle: Cycle) -> Array:
    """Shift less the mean slope times Q and less its mean: the loop keeps its area and opens."""
    shift = cycle.rigid_shift - loop_compliance(cycle) * cycle.tangential_load
    return np.asarray(shift - shift.mean())


def loop_compliance(cycle: Cycle) -> float:
    """Slope dU/dQ of the straight line through the loop, least squares; 0 where Q stands still."""
    load = cycle.tangential_load - cycle.tangential_load.mean()
    square = float(load @ load)
    return float(load @ cycle.rigid_shift) / square if square > 0 else 0.0


def places(comparison: Comparison, count: int = 4) -> list[int]:
    """Points whose slip is worth a look: from the permanent stick zone (or the middle) to just outside the largest contact.

    Indices into the result's points, on the right-hand side, none twice.
    """
    expected, x = comparison.expected, comparison.found.x
    outer = float(np.nanmax(np.abs(expected.contact_edges), initial=0.0)) or float(np.abs(x).max())
    inner = comparison.reference.permanent_stick_half_width
    inner = float(inner) if np.isfinite(inner) and inner < outer else 0.0
    wanted = inner + np.linspace(0.12, 0.97, count) * (outer - inner)
    return sorted({int(np.abs(x - place).argmin()) for place in wanted})


def slip_histories(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Slip of chosen points through the last cycle, both engines, from where each stood at the start of the cycle."""
    rows = places(comparison)
    length, scale = units(comparison.scene)[1], comparison.scales.half_width
    cycles = (("r", comparison.expected, comparison.reference), ("f", comparison.found, comparison.result))
    slips = {who: cycle.slip[:, rows] - cycle.slip[0, rows] for who, cycle, _ in cycles}
    axes = (
        Axis(*limits(time, margin=0), time_words, count=8),
        Axis(*limits(*slips.values(), zero=True, least=1e-12 * scale), f"slip since the start  [{length}]"),
    )
    area = frame(*axes, width=900.0, height=320.0)
    lines = [
        marks.curve(
            area,
            time,
            slips[who][:, k],
            f"{'wide' if who == 'r' else 'thin'} point-{k}",
            f"x = {comparison.found.x[row] / scale:.3f} a_ref, {name_of(solution.engine)}",
        )
        for who, _, solution in cycles
        for k, row in enumerate(rows)
    ]
    return Plate(
        "slip_history",
        "Slip of chosen points",
        "Upper body over the lower, counted from the start of the cycle; it goes on as relative displacement while a point is "
        "open. Broad pale line: reference; thin dark line: result.",
        "Slip over time of a few points of the surface, for both engines.",
        (panel(area, *axes, lines, "Slip of chosen points over time", clip="slip", time="x", css="broad"),),
        {"time": comparison.found.time}
        | {
            f"slip_{who}(x = {comparison.found.x[row]:.6g}) [{length}]": cycle.slip[:, row] - cycle.slip[0, row]
            for row in rows
            for who, cycle in (("reference", comparison.expected), ("result", comparison.found))
        },
        tuple(Key(f"thin point-{k}", f"x = {comparison.found.x[row] / scale:.3f} a_ref") for k, row in enumerate(rows)),
        columns=1,
    )
