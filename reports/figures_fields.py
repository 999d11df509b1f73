"""Figures over x: tractions, the stick/slip map, pointwise dissipation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reports.charts import marks
from reports.charts.panel import Axis, frame, panel
from reports.charts.plate import Key, Plate
from reports.charts.scale import limits
from reports.comparison import Comparison
from reports.definitions import name_of
from reports.drawing import STATE_NAMES, Table
from reports.instants import Event
from reports.sampling import Cycle
from reports.units import signed
from reports.wording import value_of
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK

Array = NDArray[np.float64]
X = "x / a_ref"
STATES = {
    OPEN: "#ffffff",
    STICK: "#d2d2d2",
    SLIP_FORWARD: "#e69f00",
    SLIP_REVERSE: "#0072b2",
}
STATE_KEYS = tuple(Key(f"state-{int(state)}", name, patch=True) for state, name in STATE_NAMES.items())
_COLUMNS, _ROWS = 440, 360


def reach(comparison: Comparison, share: float = 1.12) -> float:
    """Largest |x|/a_ref that is drawn: a little more than the largest contact of either."""
    edges = (comparison.expected.contact_edges, comparison.found.contact_edges)
    outer = max(float(np.nanmax(np.abs(e), initial=0.0)) for e in edges) or float(np.abs(comparison.found.x).max())
    return min(share * outer, float(np.abs(comparison.found.x).max())) / comparison.scales.half_width


def traction_keys(comparison: Comparison) -> tuple[Key, ...]:
    """The legend of a figure of tractions."""
    theirs, ours = name_of(comparison.reference.engine), name_of(comparison.result.engine)
    lines = (("r p", f"p, {theirs}"), ("r q", f"q, {theirs}"), ("f p", f"p, {ours}"), ("f q", f"q, {ours}"))
    return tuple(Key(css, text) for css, text in (*lines, ("d p", "difference of p"), ("d q", "difference of q")))


def tractions(comparison: Comparison, chosen: Sequence[Event]) -> Plate:
    """p and q of both engines at the chosen instants, the difference beneath."""
    rows = [event.index for event in chosen]
    cells = tuple(
        f'<div class="cell" data-event="{event.index}">'
        + "".join(traction_panels(comparison, event.index, rows, f"event-{number}", (320.0, 220.0), f"{number}  {event.label}"))
        + "</div>"
        for number, event in enumerate(chosen, start=1)
    )
    return Plate(
        "tractions",
        "Pressure and shear traction at chosen instants",
        "Tractions in p_ref and f p_ref; beneath each, result less reference in per cent of the same scales.",
        "Panels of pressure and shear over x for both engines, each with the difference beneath.",
        cells,
        _traction_table(comparison, rows),
        traction_keys(comparison),
        columns=3,
    )


def traction_panels(
    comparison: Comparison,
    k: int,
    rows: Sequence[int],
    clip: str,
    size: tuple[float, float],
    title: str = "",
    *,
    live: bool = False,
) -> tuple[str, str]:
    """Tractions at instant k in a drawing of that size, and the difference; axes hold the instants of `rows`.

    `live` if the slider moves them.
    """
    width, height = size
    expected, found, scales = comparison.expected, comparison.found, comparison.scales
    x, wide, every = found.x / scales.half_width, reach(comparison), list(rows)
    near = np.abs(x) <= wide * 1.02
    sizes = {"p": scales.pressure, "q": scales.shear}
    names = {"p": "pressure", "q": "shear"}
    both = {key: [getattr(cycle, names[key])[:, near] / sizes[key] for cycle in (expected, found)] for key in "pq"}
    apart = {key: 100 * (pair[1] - pair[0]) for key, pair in both.items()}
    tall = limits(*(series[every] for pair in both.values() for series in pair), zero=True)
    above = Axis(-wide, wide, ""), Axis(*tall, "p/p_ref,  q/(f p_ref)")
    below = (
        Axis(-wide, wide, X),
        Axis(*limits(*(d[every] for d in apart.values()), zero=True, least=1e-9), "difference, %", count=3),
    )
    upper = frame(*above, width, height, top=26.0 if title else 12.0, bottom=20.0)
    lower = frame(*below, width, 0.56 * height)
    engines = {"r": comparison.reference, "f": comparison.result}
    lines = [marks.horizontal(upper, 0.0, "zero")] + [
        marks.curve(
            upper, x[near], both[key][number][k], f"{who} {key}", f"{key}, {name_of(engines[who].engine)}",
            data_field=f"{key}{number}" if live else None,
        )
        for number, who in enumerate("rf")
        for key in "pq"
    ]  # fmt: skip
    differences = [marks.horizontal(lower, 0.0, "zero")] + [
        marks.curve(lower, x[near], apart[key][k], f"d {key}", f"difference of {key}, %", data_field=f"d{key}" if live else None)
        for key in "pq"
    ]
    heading = marks.words(upper.x.start, 16, title, class_="title") if title else ""
    return (
        panel(upper, *above, lines, f"Pressure and shear over x. {title}".strip(), clip=clip, extra=heading),
        panel(lower, *below, differences, f"Result less reference over x. {title}".strip(), clip=f"{clip}-difference"),
    )


def _traction_table(comparison: Comparison, rows: Sequence[int]) -> Table:
    expected, found, scales = comparison.expected, comparison.found, comparison.scales
    points, chosen = len(found.x), list(rows)
    return {
        "time": np.repeat(found.time[chosen], points),
        "x": np.tile(found.x, len(chosen)),
        "x/a_ref": np.tile(found.x / scales.half_width, len(chosen)),
        "p_reference/p_ref": (expected.pressure[chosen] / scales.pressure).ravel(),
        "p_result/p_ref": (found.pressure[chosen] / scales.pressure).ravel(),
        "q_reference/(f p_ref)": (expected.shear[chosen] / scales.shear).ravel(),
        "q_result/(f p_ref)": (found.shear[chosen] / scales.shear).ravel(),
    }


def zones(comparison: Comparison, k: int, width: float) -> str:
    """Open, stick and slip along x at instant k, a strip for each engine; the slider recolours them."""
    wide = reach(comparison)
    axes = Axis(-wide, wide, ""), Axis(0.0, 1.0, "")
    area = frame(*axes, width, 84.0, top=0.0, bottom=0.0)
    left, _, right, _ = area.box
    parts = []
    pairs = ((comparison.expected, comparison.reference), (comparison.found, comparison.result))
    for number, (cycle, solution) in enumerate(pairs):
        top = 20.0 + 40.0 * number
        parts.append(marks.words(left, top - 5, name_of(solution.engine), class_="tick"))
        inside = "".join(
            marks.element("rect", x=a, y=top, width=b - a, height=16, class_=f"state-{s}")
            for a, b, s in _runs(cycle, k, area, comparison)
        )
        parts.append(marks.element("g", inside or " ", class_="strip", data_strip=number, data_top=top))
        parts.append(marks.element("rect", x=left, y=top, width=right - left, height=16, class_="outline"))
    return marks.element(
        "svg",
        "".join(parts),
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {width:g} 84",
        role="img",
        aria_label="Open, stick and slip along x, a strip for each engine",
        class_="panel zones",
        id="panel-zones",
        data_x=area.x.words,
        data_y=area.y.words,
    )


def _runs(cycle: Cycle, k: int, area: marks.Frame, comparison: Comparison) -> list[tuple[float, float, int]]:
    """Left end, right end and state of every stretch of one state, in the frame."""
    x = cycle.x / comparison.scales.half_width
    middles = np.clip(area.x.place((x[1:] + x[:-1]) / 2), area.x.start, area.x.end)
    turns = np.flatnonzero(np.diff(cycle.state[k]))
    ends = [area.x.start, *(float(middles[t]) for t in turns), area.x.end]
    states = [int(cycle.state[k, 0]), *(int(cycle.state[k, t + 1]) for t in turns)]
    return [(a, b, s) for a, b, s in zip(ends[:-1], ends[1:], states, strict=True) if b > a]


def _share_that_differs(comparison: Comparison) -> str:
    """The metric of the map in words: points crowd at the edges, so that counting them would tell another, larger share."""
    metric = comparison.metric("state")
    return "" if metric.value is None else f" They differ over {value_of(metric)} of the length in contact, in the mean over time."


def state_map(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Open, stick, forward and reverse slip over x and time, for both engines and where they differ."""
    expected, found, length = comparison.expected, comparison.found, comparison.scales.half_width
    wide = reach(comparison)
    inside = np.flatnonzero(np.abs(found.x) <= wide * length)
    axes = Axis(-wide, wide, X), Axis(*limits(time, margin=0), time_words)
    area = frame(*axes, 340.0, 320.0, top=26.0)
    columns = np.abs(found.x[:, None] / length - np.linspace(-wide, wide, _COLUMNS)).argmin(axis=0)
    rows = np.abs(time[:, None] - np.linspace(time[-1], time[0], _ROWS)).argmin(axis=0)
    colours = list(STATES.values())
    differs = expected.state != found.state
    maps = (
        (expected.state, colours, name_of(comparison.reference.engine), "map-reference"),
        (found.state, colours, name_of(comparison.result.engine), "map-result"),
        (differs.astype(np.uint8), ["#ffffff", "#111111"], "where they differ (black)", "map-difference"),
    )
    codes = ", ".join(f"{int(state)} {name}" for state, name in STATE_NAMES.items())
    return Plate(
        "state_map",
        "Stick and slip over x and time",
        "State of each surface point at each instant of the last cycle; time runs upwards." + _share_that_differs(comparison),
        "Two maps of open, stick, forward slip and reverse slip over x and time, one for each engine, and a third of "
        "their difference.",
        tuple(
            panel(
                area,
                *axes,
                [marks.image(area, states[np.ix_(rows, columns)].astype(np.uint8), palette)],
                f"Map of states: {words}",
                clip=clip,
                time="y",
                extra=marks.words(area.x.start, 17, words, class_="title"),
                css="pick",
            )
            for states, palette, words, clip in maps
        ),
        {
            "time": np.repeat(found.time, len(inside)),
            "x": np.tile(found.x[inside], len(time)),
            f"state_reference ({codes})": expected.state[:, inside].ravel(),
            f"state_result ({codes})": found.state[:, inside].ravel(),
        },
        STATE_KEYS,
        columns=3,
    )


def dissipation_density(comparison: Comparison) -> Plate | None:
    """w(x) of the last cycle, both engines, the difference beside it; None where nothing is dissipated anywhere."""
    if not (np.any(comparison.expected.dissipation_density) or np.any(comparison.found.dissipation_density)):
        return None
    scales, x, wide = comparison.scales, comparison.found.x / comparison.scales.half_width, reach(comparison)
    unit = scales.dissipation / scales.half_width
    theirs, ours = comparison.expected.dissipation_density / unit, comparison.found.dissipation_density / unit
    axes = Axis(-wide, wide, X), Axis(*limits(theirs, ours, zero=True), "w / (A f² P_ref²/a_ref)")
    area = frame(*axes)
    engines = (("r", theirs, comparison.reference), ("f", ours, comparison.result))
    lines = [
        marks.vertical(area, side * float(stick) / scales.half_width, "stick-line")
        for side in (-1, 1)
        if np.isfinite(stick := comparison.reference.permanent_stick_half_width)
    ]
    lines += [marks.curve(area, x, w, f"{who} p", name_of(solution.engine)) for who, w, solution in engines]
    peak = int(np.nanargmax(np.where(np.isfinite(ours), ours, -np.inf)))
    lines.append(marks.dot(area, float(x[peak]), float(ours[peak]), "event"))
    differences = axes[0], Axis(*limits(ours - theirs, zero=True, least=1e-12), "difference")
    beside = frame(*differences)
    apart = [marks.horizontal(beside, 0.0, "zero"), marks.curve(beside, x, ours - theirs, "d p", "difference")]
    stuck = f"; dashed: edges of the permanent stick zone, ±{stick / scales.half_width:.4g} a_ref" if np.isfinite(stick) else ""
    return Plate(
        "dissipation_density",
        "Dissipation, point by point",
        "First: friction work per unit area in the last cycle. Dot: the peak, "
        f"{ours[peak]:.4g} at x = {signed(float(x[peak]))} a_ref{stuck}. Second: result less reference.",
        "Dissipation density over x for both engines, and the difference.",
        (
            panel(area, *axes, lines, "Dissipation density over x", clip="work", css="pick"),
            panel(beside, *differences, apart, "Difference of the dissipation density", clip="work-difference"),
        ),
        {
            "x": comparison.found.x,
            "x/a_ref": x,
            "w_reference/(A f^2 P_ref^2/a_ref)": theirs,
            "w_result/(A f^2 P_ref^2/a_ref)": ours,
        },
        (*(Key(f"{who} p", name_of(solution.engine)) for who, _, solution in engines), Key("d p", "difference")),
    )
