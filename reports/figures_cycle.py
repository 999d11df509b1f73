"""Figures through time and in the plane of the loads: half-widths, errors, load path, hysteresis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from reports.comparison import Comparison
from reports.definitions import name_of
from reports.drawing import (
    BANDS,
    COLOURS,
    DIFFERENCE,
    LINES,
    QUIET,
    THIN,
    Drawing,
    canvas,
    label_axes,
    legend_above,
)
from reports.instants import Event
from reports.sampling import Cycle
from reports.units import load_unit, units
from reports.verdicts import Metric
from scenes import ContactSolution, StraightLeg

Array = NDArray[np.float64]


def half_widths(comparison: Comparison, time: Array, time_label: str) -> Drawing:
    """Contact and stick edges of both engines through the last cycle, the difference beneath."""
    length = comparison.scales.half_width
    with canvas(10.5, 4.8) as figure:
        top, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1))
        figure.subplots_adjust(left=0.085, right=0.985, top=0.93, bottom=0.1, hspace=0.24)
        for cycle, engine, styles in (
            (comparison.expected, comparison.reference, BANDS),
            (comparison.found, comparison.result, THIN),
        ):
            for edges, what, style in zip(("contact_edges", "stick_edges"), ("contact", "stick"), styles, strict=True):
                top.plot(time, _half(cycle, edges) / length, label=f"{what}, {name_of(engine.engine)}", **style)
        legend_above(top)
        for edges, what, line in (("contact_edges", "contact", "-"), ("stick_edges", "stick", "--")):
            difference = (_half(comparison.found, edges) - _half(comparison.expected, edges)) / length
            below.plot(time, difference, color=DIFFERENCE, ls=line, lw=1.1, label=what)
        legend_above(below)
        label_axes(top, "", "half-width / a_ref")
        label_axes(below, time_label, "difference / a_ref")
    return Drawing(
        "half_widths",
        "Contact and stick half-width through the cycle",
        "Half the distance between the edges. In full stick the stick edges are the contact edges; in full slip there are none.",
        "Contact and stick half-width over time for both engines with the difference beneath.",
        figure,
        {
            "time": comparison.found.time,
            **{
                f"{side}_{edges}_{who}": getattr(cycle, edges)[:, column]
                for who, cycle in (("reference", comparison.expected), ("result", comparison.found))
                for edges in ("contact_edges", "stick_edges")
                for column, side in enumerate(("left", "right"))
            },
        },
    )


def _half(cycle: Cycle, edges: str) -> Array:
    pair = getattr(cycle, edges)
    return np.asarray((pair[:, 1] - pair[:, 0]) / 2)


def errors(comparison: Comparison, time: Array, time_label: str) -> Drawing:
    """Every metric that has a tolerance and a value at each instant, over its tolerance, at the instants that are judged."""
    shown = [m for m in comparison.metrics if m.series is not None and m.tolerance is not None]
    with canvas(10.5, 3.4) as figure:
        axes = figure.subplots()
        figure.subplots_adjust(left=0.085, right=0.985, top=0.88, bottom=0.14)
        for metric, line, colour in zip(shown, LINES, COLOURS, strict=False):
            size = np.where(comparison.judged, np.abs(np.asarray(metric.series)) / (metric.tolerance or 1.0), np.nan)
            axes.plot(time, size, ls=line, color=colour, label=metric.label)
        axes.axhline(1.0, color=QUIET, lw=1.0)
        axes.text(0.995, 1.0, "tolerance", transform=axes.get_yaxis_transform(), ha="right", va="bottom", color=QUIET)
        largest = max((_largest(m, comparison) for m in shown), default=1.0)
        axes.set_ylim(0.0, 1.08 * min(max(1.0, largest), 8.0))
        legend_above(axes, columns=5)
        label_axes(axes, time_label, "|discrepancy| / tolerance")
    return Drawing(
        "errors",
        "Discrepancy through the cycle",
        "Each metric over its own tolerance, at the instants that are judged: above 1 it fails.",
        "Discrepancies over their tolerances through the last cycle.",
        figure,
        {"time": comparison.found.time} | {m.key: np.asarray(m.series) for m in shown},
    )


def _largest(metric: Metric, comparison: Comparison) -> float:
    """The largest |value| of a metric at the instants that are judged, over its tolerance."""
    judged = np.abs(np.asarray(metric.series))[comparison.judged]
    return float(np.nanmax(judged, initial=0.0)) / (metric.tolerance or 1.0)


def load_path(solution: ContactSolution, cycle: Cycle, chosen: Sequence[Event]) -> Drawing:
    """The path in the P-Q plane: way in, cycle, friction cone, chosen instants."""
    friction = solution.scene.friction.coefficient
    path = solution.scene.load.path()
    legs = [(leg, "way in") for leg in path.way_in] + [(leg, "cycle") for leg in path.cycle]
    samples = [(np.linspace(leg.start, leg.end, 2 if isinstance(leg, StraightLeg) else 257), part) for leg, part in legs]
    time = np.concatenate([t for t, _ in samples])
    part = np.concatenate([np.full(len(t), name) for t, name in samples])
    normal, tangential = path.at(time)
    with canvas(4.2, 4.0) as figure:
        axes = figure.subplots()
        figure.subplots_adjust(left=0.17, right=0.97, top=0.92, bottom=0.125)
        top = 1.08 * float(normal.max())
        if friction:
            axes.plot([0, top], [0, friction * top], color=QUIET, lw=0.9, ls=":", label="|Q| = f P")
            axes.plot([0, top], [0, -friction * top], color=QUIET, lw=0.9, ls=":")
        for name, line in (("way in", "--"), ("cycle", "-")):
            if (part == name).any():
                axes.plot(normal[part == name], tangential[part == name], line, color="black", label=name)
        _mark_events(axes, cycle.normal_load, cycle.tangential_load, chosen)
        reach = 1.25 * max(float(np.abs(tangential).max()), 0.15 * top)
        axes.set_xlim(0, top)
        axes.set_ylim(min(-0.3 * reach, 1.25 * float(tangential.min())), reach)
        label_axes(axes, f"normal load P  [{load_unit(solution.scene)}]", f"tangential load Q  [{load_unit(solution.scene)}]")
        legend_above(axes, columns=3)
    return Drawing(
        "load_path",
        "Load path",
        "Normal and tangential load; the numbers are the instants of the traction figure, in the order of time.",
        "Path of the loads in the plane of P and Q with the friction cone.",
        figure,
        {"time": time, "part": [str(p) for p in part], "P": normal, "Q": tangential},
    )


def _mark_events(axes: Axes, horizontal: Array, vertical: Array, chosen: Sequence[Event]) -> None:
    """Numbered dots, numbers outside the loop that the dots lie on."""
    rows = [event.index for event in chosen]
    centre = np.array([horizontal.mean(), vertical.mean()])
    spread = np.array([np.ptp(horizontal), np.ptp(vertical)])
    spread[spread == 0] = 1.0
    for number, row in enumerate(rows, start=1):
        here = np.array([horizontal[row], vertical[row]])
        outward = (here - centre) / spread
        outward = outward / (np.hypot(*outward) or 1.0)
        axes.plot(*here, "o", color="black", ms=4)
        axes.annotate(
            str(number),
            (here[0], here[1]),
            xytext=tuple(8 * outward),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8,
        )


def hysteresis(comparison: Comparison, chosen: Sequence[Event]) -> Drawing | None:
    """Tangential load over rigid shift in the last cycle, both engines; beside it sheared, so that the loop opens.

    None where neither load nor shift moves.
    """
    expected, found = comparison.expected, comparison.found
    if np.ptp(found.tangential_load) == 0 and np.ptp(found.rigid_shift) == 0 and np.ptp(expected.rigid_shift) == 0:
        return None
    compliance = _loop_compliance(expected)
    load, length = load_unit(comparison.scene), units(comparison.scene)[1]
    with canvas(7.0, 4.0) as figure:
        plain, sheared = figure.subplots(1, 2, sharey=True)
        figure.subplots_adjust(left=0.095, right=0.985, top=0.92, bottom=0.125, wspace=0.1)
        for axes, slope in ((plain, 0.0), (sheared, compliance)):
            for cycle, engine, style in (
                (expected, comparison.reference.engine, BANDS[0]),
                (found, comparison.result.engine, THIN[0]),
            ):
                shift = cycle.rigid_shift - slope * cycle.tangential_load
                axes.plot(shift, cycle.tangential_load, label=name_of(engine), **style)
            _mark_events(axes, found.rigid_shift - slope * found.tangential_load, found.tangential_load, chosen)
            axes.margins(0.1)
            axes.ticklabel_format(axis="x", scilimits=(-2, 3), useMathText=False)
        legend_above(plain, columns=2)
        label_axes(plain, f"rigid shift U  [{length}]", f"tangential load Q  [{load}]")
        label_axes(sheared, f"U − k Q  [{length}]", "")
    return Drawing(
        "hysteresis",
        "Hysteresis loop",
        f"Left: shift of the upper body over the lower. Right: the same less its mean slope, k = {compliance:.4g} "
        f"{length} per {load}, which leaves the area, the dissipation of the cycle, as it is.",
        "Tangential load over rigid shift for both engines, as it is and sheared so that the loop opens.",
        figure,
        {
            "time": found.time,
            "Q": found.tangential_load,
            "U_reference": expected.rigid_shift,
            "U_result": found.rigid_shift,
        },
    )


def _loop_compliance(cycle: Cycle) -> float:
    """Slope dU/dQ of the straight line through the loop, least squares; 0 where Q stands still."""
    load = cycle.tangential_load - cycle.tangential_load.mean()
    square = float(load @ load)
    return float(load @ cycle.rigid_shift) / square if square > 0 else 0.0
