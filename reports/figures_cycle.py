"""Figures through time: edges, errors, slip of chosen points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reports.charts import marks
from reports.charts.panel import Axis, frame, panel
from reports.charts.plate import Key, Plate
from reports.charts.scale import limits
from reports.comparison import Comparison
from reports.definitions import name_of
from reports.sampling import Cycle
from reports.units import units
from reports.verdicts import Metric
from scenes import ContactSolution

Array = NDArray[np.float64]
LINES = tuple(f"line-{k}" for k in range(7))


def sides(comparison: Comparison) -> tuple[tuple[str, Cycle, ContactSolution], ...]:
    """Class of its lines, last cycle and answer: of the reference, then of the result."""
    return ("r", comparison.expected, comparison.reference), ("f", comparison.found, comparison.result)


def half_widths(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Contact and stick edges of both engines through the last cycle, the difference of the half-widths beside them."""
    length = comparison.scales.half_width
    cycles = sides(comparison)
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
        "First: where contact and stick end. Second: half the distance between the edges, result less reference. In full stick "
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
    cycles = sides(comparison)
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
