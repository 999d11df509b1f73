"""Figures of the page: tractions and zones at instants, the cycle over time, loops, dissipation, checks, error budget."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Axis, Bitmap, Block, Curve, Dot, Group, Mark, Note, Rule, Segments
from reports.charts.plate import STATE_KEYS, Cell, Key, Panel, Plate
from reports.charts.scale import limits
from reports.charts.style import STATE_NAMES
from reports.comparison import Comparison
from reports.comparison.budget import ROUNDING, Budget, ErrorBudget
from reports.comparison.convergence import Ladder, extrapolate
from reports.comparison.cycles import Cycle, Event, events
from reports.comparison.laws import LIMIT, Certificate
from reports.comparison.metrics import are_half_planes, bulk_strain, bulk_work, loop_work, missing, name_of
from reports.comparison.words import value_of
from reports.units import energy_unit, load_unit, minus, signed, units
from scenes import ContactSolution, Scene, sampled
from scenes.scene import OWN_TOLERANCES

if TYPE_CHECKING:
    from reports.scoring.study import Study

Array = NDArray[np.float64]
X = "x / a_ref"
# Looks of lines, one after the other, then from the first again.
LINES = tuple(f"line-{k}" for k in range(7)) * 3
# Open, stick, forward and reverse slip on a map, which has no style sheet.
_STATES = ("#ffffff", "#d2d2d2", "#e69f00", "#0072b2")
_COLUMNS, _ROWS = 440, 360
# Rows of the table of states: of a long path evenly many instants, 25 MB.
_MOST_STATES = 500_000


# ------------------------------------------------------------------------------------------------------------- what many share
def sides(comparison: Comparison) -> tuple[tuple[str, Cycle, str], ...]:
    """Look of its lines, last cycle and name: of the reference, then of the result."""
    return (
        ("r", comparison.expected, name_of(comparison.reference.engine)),
        ("f", comparison.found, name_of(comparison.result.engine)),
    )


def reach(comparison: Comparison, share: float = 1.12) -> float:
    """Largest |x|/a_ref that is drawn: a little more than the largest contact of either."""
    edges = (comparison.expected.contact_edges, comparison.found.contact_edges)
    outer = max(float(np.nanmax(np.abs(e), initial=0.0)) for e in edges) or float(np.abs(comparison.found.x).max())
    return min(share * outer, float(np.abs(comparison.found.x).max())) / comparison.scales.half_width


def first_shown(cycle: Cycle, chosen: Sequence[Event]) -> int:
    """The instant that a page shows first: of the chosen ones that with most points slipping, of equal ones the most loaded."""
    return max((event.index for event in chosen), key=lambda k: (int((cycle.state[k] >= 2).sum()), float(cycle.normal_load[k])))


def measured(difference: Array, along: Array, where: str, unit: str = "", weight: NDArray[np.bool_] | None = None) -> str:
    """The numbers of a difference (n,) along x or time (n,): root mean square over the length, the largest value, its place.

    >>> measured(np.array([0.0, -3.0, 0.0]), np.array([0.0, 1.0, 2.0]), "x = {} a_ref", " %")
    'rms 1.7 %, largest −3 % at x = 1 a_ref'
    """
    known = np.isfinite(difference) & (True if weight is None else weight)
    if not known.any():
        return "nothing to compare"
    lengths = np.gradient(along) if len(along) > 1 else np.ones(1)
    rms = np.sqrt(np.average(difference[known] ** 2, weights=np.maximum(lengths[known], 1e-300)))
    worst = int(np.argmax(np.where(known, np.abs(difference), -1.0)))
    place = where.format(minus(f"{along[worst] + 0.0:.3g}"))
    size, most = (f"{v:.2g}" if abs(v) < 100 else f"{v:.0f}" for v in (rms, difference[worst] + 0.0))
    return minus(f"rms {size}{unit}, largest {most}{unit} at ") + place


def _broad(name: str, x: Axis, y: Axis, marks: Sequence[Mark], alt: str, height: float = 280.0, **more: Any) -> Panel:
    """A panel as wide as the page."""
    return Panel(name, x, y, marks, alt, 900.0, height, css="broad", **more)


def _when(time_words: str) -> str:
    """Where a time stands in a sentence."""
    return "t/T = {}" if "period" in time_words else "t = {}"


# ------------------------------------------------------------------------------------------------------------------- over x
def traction_keys(comparison: Comparison) -> tuple[Key, ...]:
    """The legend of a figure of tractions."""
    lines = [Key(f"{who} {key}", f"{key}, {name}") for who, _, name in sides(comparison) for key in "pq"]
    return (*lines, Key("d p", "difference of p"), Key("d q", "difference of q"))


def tractions(comparison: Comparison, chosen: Sequence[Event]) -> Plate:
    """p and q of both engines at the chosen instants, the difference beneath."""
    rows = [event.index for event in chosen]
    cells = tuple(
        Cell(traction_panels(comparison, event.index, rows, f"event-{n}", (320.0, 220.0), f"{n}  {event.label}"), event.index)
        for n, event in enumerate(chosen, start=1)
    )
    expected, found, scales, points = comparison.expected, comparison.found, comparison.scales, len(comparison.found.x)
    return Plate(
        "tractions",
        "Pressure and shear traction at chosen instants",
        "Tractions in p_ref and f p_ref; beneath each, result − reference in per cent of the same scales, with its root mean "
        "square over the contact and its largest value. Peaks at the edges are one or two elements wide: the mesh, not the theory.",
        "Panels of pressure and shear over x for both engines, each with the difference beneath.",
        cells,
        {
            "time": np.repeat(found.time[rows], points),
            "x": np.tile(found.x, len(rows)),
            "x/a_ref": np.tile(found.x / scales.half_width, len(rows)),
            "p_reference/p_ref": (expected.pressure[rows] / scales.pressure).ravel(),
            "p_result/p_ref": (found.pressure[rows] / scales.pressure).ravel(),
            "q_reference/(f p_ref)": (expected.shear[rows] / scales.shear).ravel(),
            "q_result/(f p_ref)": (found.shear[rows] / scales.shear).ravel(),
        },
        traction_keys(comparison),
        columns=3,
    )


def traction_panels(
    comparison: Comparison,
    k: int,
    rows: Sequence[int],
    name: str,
    size: tuple[float, float],
    title: str = "",
    *,
    live: bool = False,
) -> tuple[Panel, Panel]:
    """Tractions at instant k in a drawing of that size, and the difference; axes hold the instants of `rows`.

    `live` if the slider moves them.
    """
    width, height = size
    expected, found, scales = comparison.expected, comparison.found, comparison.scales
    x, wide = found.x / scales.half_width, reach(comparison)
    near = np.abs(x) <= wide * 1.02
    fields = {"p": ("pressure", scales.pressure), "q": ("shear", scales.shear)}
    # Instant k, which is drawn, before the others that the axes hold; a line copies its row, or it would keep all in memory.
    grid = np.ix_(np.array(list(dict.fromkeys((k, *rows)))), np.flatnonzero(near))
    both = {key: [getattr(cycle, field)[grid] / unit for cycle in (expected, found)] for key, (field, unit) in fields.items()}
    apart = {key: 100 * (pair[1] - pair[0]) for key, pair in both.items()}
    touching = (both["p"][0][0] != 0) | (both["p"][1][0] != 0)

    def curve(values: Array, css: str, label: str, field: str) -> Curve:
        return Curve(x[near], values.copy(), css, label, {"field": field} if live else {})

    lines: list[Mark] = [Rule(0.0, "zero")]
    for n, (who, _, engine) in enumerate(sides(comparison)):
        lines += [curve(both[key][n][0], f"{who} {key}", f"{key}, {engine}", f"{key}{n}") for key in "pq"]
    differences = [curve(apart[key][0], f"d {key}", f"difference of {key}, %", f"d{key}") for key in "pq"]
    up = Axis(*limits(*(series for pair in both.values() for series in pair), zero=True), "p/p_ref,  q/(f p_ref)")
    below = Axis(*limits(*apart.values(), zero=True, least=1e-9), "difference, %", count=3)
    notes = [f"{key}: {measured(apart[key][0], x[near], 'x = {} a_ref', ' %', touching)}" for key in "pq"]
    alts = [f"{what} over x. {title}".strip() for what in ("Pressure and shear", "Result less reference")]
    room = (72.0, 26.0 if title else 12.0, 20.0, 20.0)
    marks: list[Mark] = [Rule(0.0, "zero"), *differences]
    return (
        Panel(name, Axis(-wide, wide, ""), up, lines, alts[0], width, height, title, room=room),
        Panel(f"{name}-difference", Axis(-wide, wide, X), below, marks, alts[1], width, 0.56 * height + 56, notes=notes),
    )


def published(comparison: Comparison) -> str:
    """The picture of a published scene, two panels as SVG: tractions at the largest load, and the loop or the half-widths."""
    expected, scene = comparison.expected, comparison.scene
    # Where P is largest, and of these instants where |Q| is.
    largest = expected.normal_load >= expected.normal_load.max() * (1 - 1e-9)
    k = int(np.argmax(np.where(largest, np.abs(expected.tangential_load), -1.0)))
    first, _ = traction_panels(comparison, k, [k], "tractions", (440.0, 330.0), f"t = {expected.time[k]:.4g}")
    first = replace(first, x=replace(first.x, words=X), room=None)
    moves = np.ptp(expected.tangential_displacement) > 1e-9 * comparison.scales.shift
    loop = hysteresis(comparison, events(comparison.found, scene.friction.coefficient)) if moves else None
    beside = loop.panels[1] if loop else half_widths(comparison, comparison.found.time, "time").panels[0]
    keys, title = traction_keys(comparison)[:4], scene.title or scene.name
    return Plate(scene.name, title, "", f"Both engines on {scene.name}", (first, beside), {}, keys).svg() + "\n"


def now(comparison: Comparison, chosen: Sequence[Event]) -> Plate:
    """Both engines at the chosen instant with most slip; axes hold the whole cycle, so that nothing leaves them as it moves."""
    expected, found = comparison.expected, comparison.found
    start, every, width = first_shown(found, chosen), range(len(found.time)), 560.0
    above, difference = traction_panels(comparison, start, every, "now", (width, 300.0), live=True)
    return Plate(
        "cycle",
        "The instant shown",
        "Tractions of both engines, what each point does, and result − reference with its root mean square over the contact and "
        "its largest value.",
        "Pressure and shear of both engines at one instant, zones of stick and slip, and their difference.",
        (above, _zones(comparison, start, width), difference),
        {
            "time": found.time,
            "fraction": found.fraction,
            "P": found.normal_load,
            "Q": found.tangential_load,
            "U_reference": expected.tangential_displacement,
            "U_result": found.tangential_displacement,
            "points_where_states_differ": (expected.state != found.state).sum(axis=1).astype(np.int64),
        },
        traction_keys(comparison),
        columns=1,
    )


def _zones(comparison: Comparison, k: int, width: float) -> Panel:
    """Open, stick and slip along x at instant k, a strip for each engine; the slider recolours them."""
    wide, marks = reach(comparison), list[Mark]()
    for number, (_, cycle, engine) in enumerate(sides(comparison)):
        top = 20.0 + 40.0 * number
        x = cycle.x / comparison.scales.half_width
        turns = np.flatnonzero(np.diff(cycle.state[k]))
        ends = [-wide, *np.clip((x[turns + 1] + x[turns]) / 2, -wide, wide).tolist(), wide]
        states = cycle.state[k, [0, *(turns + 1).tolist()]].tolist()
        runs = zip(ends[:-1], ends[1:], states, strict=True)
        blocks = tuple(Block((a, b), (top, top + 16), f"state-{s}") for a, b, s in runs if b > a)
        marks += [Note(-wide, top - 5, engine), Group(blocks, "strip", {"strip": number, "top": f"{top:g}"})]
        marks.append(Block((-wide, wide), (top, top + 16), "outline"))
    alt = "Open, stick and slip along x, a strip for each engine"
    room = (72.0, 0.0, 20.0, 0.0)
    return Panel("zones", Axis(-wide, wide, ""), Axis(84.0, 0.0, ""), marks, alt, width, 84.0, css="zones", bare=True, room=room)


def state_map(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Open, stick, forward and reverse slip over x and time, for both engines and where they differ."""
    expected, found, length = comparison.expected, comparison.found, comparison.scales.half_width
    wide = reach(comparison)
    inside = np.flatnonzero(np.abs(found.x) <= wide * length)
    columns = np.abs(found.x[:, None] / length - np.linspace(-wide, wide, _COLUMNS)).argmin(axis=0)
    rows = np.abs(time[:, None] - np.linspace(time[-1], time[0], _ROWS)).argmin(axis=0)
    written = np.linspace(0, len(time) - 1, min(len(time), max(_MOST_STATES // len(inside), 2))).round().astype(int)
    metric = comparison.metric("state")
    # The metric's own number: points crowd at the edges, so that counting them would give another, larger share.
    share = "" if metric.value is None else value_of(metric)
    caption = "State of each surface point at each instant of the last cycle; time runs upwards."
    caption += f" They differ over {share} of the length in contact, in the mean over time." if share else ""
    caption += "" if len(written) == len(time) else f" The CSV holds {len(written)} of the {len(time)} instants."
    roles = ("map-reference", "map-result")
    maps: list[tuple[str, NDArray[Any], tuple[str, ...], str]] = [
        (role, cycle.state, _STATES, name) for role, (_, cycle, name) in zip(roles, sides(comparison), strict=True)
    ]
    differ = f"they differ: {share}" if share else "they differ"
    maps.append(("map-difference", expected.state != found.state, ("#ffffff", "#111111"), differ))
    panels = []
    for name, states, palette, words in maps:
        marks = [Bitmap(states[np.ix_(rows, columns)].astype(np.uint8), palette)]
        axes = Axis(-wide, wide, X), Axis(*limits(time, margin=0), time_words)
        panels.append(Panel(name, *axes, marks, f"Map of states: {words}", 340.0, 320.0, words, time="y", css="pick"))
    codes = ", ".join(f"{int(state)} {name}" for state, name in STATE_NAMES.items())
    return Plate(
        "state_map",
        "Stick and slip over x and time",
        caption,
        "Two maps of open, stick, forward slip and reverse slip over x and time, one for each engine, and a third of "
        "their difference.",
        tuple(panels),
        {
            "time": np.repeat(found.time[written], len(inside)),
            "x": np.tile(found.x[inside], len(written)),
            f"state_reference ({codes})": expected.state[np.ix_(written, inside)].ravel(),
            f"state_result ({codes})": found.state[np.ix_(written, inside)].ravel(),
        },
        STATE_KEYS,
        columns=3,
    )


def dissipation_density(comparison: Comparison) -> Plate | None:
    """w(x) of the last cycle, both engines, the difference beside it; None where nothing is dissipated anywhere."""
    scales, x, wide = comparison.scales, comparison.found.x / comparison.scales.half_width, reach(comparison)
    unit = scales.dissipation / scales.half_width
    theirs, ours = (cycle.dissipation_density / unit for _, cycle, _ in sides(comparison))
    if not (np.any(theirs) or np.any(ours)):
        return None
    stick = permanent_edges(comparison.reference) / scales.half_width
    lines: list[Mark] = [Rule(float(edge), "stick-line", upright=True) for edge in stick if np.isfinite(edge)]
    keys = [Key(f"{who} p", name) for who, _, name in sides(comparison)]
    lines += [Curve(x, w, key.css, key.text) for w, key in zip((theirs, ours), keys, strict=True)]
    peak = int(np.nanargmax(np.where(np.isfinite(ours), ours, -np.inf)))
    lines.append(Dot(float(x[peak]), float(ours[peak]), "event"))
    apart = 100 * (ours - theirs) / (float(np.nanmax(np.abs(theirs), initial=0.0)) or 1.0)
    note = measured(apart, x, "x = {} a_ref", " %", (np.abs(x) <= wide) & ((theirs != 0) | (ours != 0)))
    ends = f"±{stick[1]:.4g}" if stick[0] == -stick[1] else minus(f"{stick[0]:.4g} and {stick[1]:.4g}")
    stuck = f"; dashed: edges of the permanent stick zone, {ends} a_ref" if np.isfinite(stick).all() else ""
    up = Axis(*limits(theirs, ours, zero=True), "w / (A f² P_ref²/a_ref)")
    below = Axis(*limits(apart, zero=True, least=1e-9), "difference, % of the largest")
    marks: list[Mark] = [Rule(0.0, "zero"), Curve(x, apart, "d p", "difference")]
    return Plate(
        "dissipation_density",
        "Dissipation, point by point",
        "First: friction work per unit area in the last cycle. Dot: the peak, "
        f"{ours[peak]:.4g} at x = {signed(float(x[peak]))} a_ref{stuck}. Second: result − reference, over the largest reference.",
        "Dissipation density over x for both engines, and the difference.",
        (
            Panel("work", Axis(-wide, wide, X), up, lines, "Dissipation density over x", css="pick"),
            Panel("work-difference", Axis(-wide, wide, X), below, marks, "Difference of the dissipation density", notes=[note]),
        ),
        {
            "x": comparison.found.x,
            "x/a_ref": x,
            "w_reference/(A f^2 P_ref^2/a_ref)": theirs,
            "w_result/(A f^2 P_ref^2/a_ref)": ours,
        },
        (*keys, Key("d p", "difference")),
    )


# ---------------------------------------------------------------------------------------------------------------- over time
def half_widths(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Contact and stick edges of both engines through the last cycle, the difference of the half-widths beside them."""
    length, both = comparison.scales.half_width, sides(comparison)
    lines, keys, apart, table = list[Curve](), list[Key](), dict[str, Array](), {"time": comparison.found.time}
    for who, cycle, engine in both:
        for kind, css in (("contact", "p"), ("stick", "q")):
            edges, key = getattr(cycle, f"{kind}_edges"), Key(f"{who} {css}", f"{kind} edge, {engine}")
            lines += [Curve(time, edges[:, side] / length, key.css, key.text) for side in (0, 1)]
            keys.append(key)
            half = np.ptp(edges, axis=1) / 2 / length
            apart[kind] = half - apart[kind] if kind in apart else half
            role = "reference" if who == "r" else "result"
            table |= {f"{side}_{kind}_edges_{role}": edges[:, k] for k, side in enumerate(("left", "right"))}
    x = comparison.found.x
    outer = float(np.nanmax(np.abs(comparison.found.contact_edges), initial=0.0))
    spacing = float(np.median(np.diff(x)[np.abs(np.abs(x[1:]) - outer) < 0.3 * (outer or np.inf)])) / length if outer else np.nan
    noise = f" Ripples up to about {spacing:.1g} a_ref are noise of the mesh: so far apart are the points at the edge."
    title = "Contact and stick edges through the cycle"
    across = Axis(*limits(time, margin=0), time_words)
    up = Axis(*limits(*apart.values(), zero=True, least=1e-12), "difference of half-widths / a_ref")
    marks: list[Mark] = [
        Rule(0.0, "zero"),
        Curve(time, apart["contact"], "d p", "contact"),
        Curve(time, apart["stick"], "d q", "stick"),
    ]
    notes = [f"{kind}: {measured(values, time, _when(time_words), ' a_ref')}" for kind, values in apart.items()]
    return Plate(
        "half_widths",
        title,
        "First: where contact and stick end. Second: half the distance between the edges, result − reference. In full stick "
        f"the stick edges are the contact edges; in full slip there are none.{noise if np.isfinite(spacing) else ''}",
        "Contact and stick edges over time for both engines, and the difference of the half-widths.",
        (
            Panel("edges", across, Axis(*limits(*(line.y for line in lines)), "x / a_ref"), lines, title, time="x"),
            Panel("edges-difference", across, up, marks, "Difference of the half-widths", notes=notes, time="x"),
        ),
        table,
        (*keys, Key("d p", "difference, contact"), Key("d q", "difference, stick")),
    )


def errors(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Metrics that have a value at each instant, at the instants that are judged: over their tolerances, where there are any.

    Where no tolerance was given, those that half-planes are judged by, in per cent.
    """
    series = [m for m in comparison.metrics if m.series is not None]
    judged = [m for m in series if m.tolerance is not None]
    shown = judged or [m for m in series if m.key in OWN_TOLERANCES]
    unit = "" if judged else " %"
    lines, keys, largest = list[Mark]([Rule(1.0, "limit")] if judged else []), [], 0.0
    for m, css in zip(shown, LINES, strict=False):
        over = (m.tolerance or 1.0) if judged else 0.01
        size = np.where(comparison.judged, np.abs(np.asarray(m.series)) / over, np.nan)
        worst = int(np.nanargmax(size)) if np.isfinite(size).any() else 0
        largest = max(largest, float(np.nanmax(size, initial=0.0)))
        lines.append(Curve(time, size, css, m.label))
        keys.append(Key(css, minus(f"{m.label}: {size[worst]:.2g}{unit} at {time[worst]:.3g}")))
    most = min(max(1.0, largest), 8.0) if judged else largest or 1.0
    caption = "Each metric in per cent of its scale, at the instants that are judged; no tolerance was given."
    if judged:
        lines.append(Note(float(time[-1]), 1.0, "tolerance", anchor="end", shift=(-4.0, -5.0)))
        caption = "Each metric over its own tolerance, at the instants that are judged: above 1 it fails."
        caption += " Curves above 8 are cut off: their values are in the CSV." if largest > 8 else ""
    title = "Discrepancy through the cycle"
    up = Axis(0.0, 1.08 * most, "|discrepancy| / tolerance" if judged else "|discrepancy|, %")
    return Plate(
        "errors",
        title,
        f"{caption} The legend has the largest value and its time. Steps from node to node are noise of the mesh.",
        "Discrepancies over their tolerances through the last cycle.",
        (_broad("errors", Axis(*limits(time, margin=0), time_words, count=8), up, lines, title, time="x"),),
        {"time": comparison.found.time} | {m.key: np.asarray(m.series) for m in shown},
        tuple(keys),
        columns=1,
    )


def permanent_edges(solution: ContactSolution) -> Array:
    """(2,) ends of what sticks through the whole last cycle [length]; NaN if nothing does."""
    if solution.permanent_stick_edges is not None:
        return solution.permanent_stick_edges
    return solution.permanent_stick_half_width * np.array([-1.0, 1.0])


def places(comparison: Comparison, count: int = 4) -> list[int]:
    """Points whose slip is worth a look: from the permanent stick zone (or the middle) to just outside the largest contact.

    Indices into the result's points, on the right-hand side, none twice.
    """
    expected, x = comparison.expected, comparison.found.x
    outer = float(np.nanmax(np.abs(expected.contact_edges), initial=0.0)) or float(np.abs(x).max())
    if comparison.turned:
        outer = float(np.nanmax(expected.contact_edges, initial=float(x[0])))
    inner = permanent_edges(comparison.reference)[1]
    inner = float(inner) if np.isfinite(inner) and inner < outer else min(0.0, outer)
    wanted = inner + np.linspace(0.12, 0.97, count) * (outer - inner)
    return sorted({int(np.abs(x - place).argmin()) for place in wanted})


def slip_histories(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Slip of chosen points through the last cycle, both engines, from where each stood at the start of the cycle."""
    rows, x, scale = places(comparison), comparison.found.x, comparison.scales.half_width
    length = units(comparison.scene)[1]
    slips = [cycle.slip[:, rows] - cycle.slip[0, rows] for _, cycle, _ in sides(comparison)]
    apart = slips[1] - slips[0]
    lines, table = [], {"time": comparison.found.time}
    for look, slip, (_, _, engine) in zip(("wide", "thin"), slips, sides(comparison), strict=True):
        for k, row in enumerate(rows):
            lines.append(Curve(time, slip[:, k], f"{look} point-{k}", f"x = {x[row] / scale:.3f} a_ref, {engine}"))
    for k, row in enumerate(rows):
        table |= {
            f"slip_{who}(x = {x[row]:.6g}) [{length}]": slip[:, k] for who, slip in zip(("reference", "result"), slips, strict=True)
        }
    point = int(np.argmax(np.nanmax(np.abs(np.nan_to_num(apart)), axis=0)))
    notes = [
        f"result − reference at x = {x[rows[point]] / scale:.3f} a_ref, where it is largest:",
        measured(apart[:, point], time, _when(time_words), f" {length}"),
    ]
    across = Axis(*limits(time, margin=0), time_words, count=8)
    up = Axis(*limits(*slips, zero=True, least=1e-12 * scale), f"slip since the start  [{length}]")
    return Plate(
        "slip_history",
        "Slip of chosen points",
        "Upper body over the lower, counted from the start of the cycle; it goes on as relative displacement while a point is "
        "open. Broad pale line: reference; thin dark line: result.",
        "Slip over time of a few points of the surface, for both engines.",
        (_broad("slip", across, up, lines, "Slip of chosen points over time", 320.0, notes=notes, time="x"),),
        table,
        tuple(Key(f"point-{k}", f"x = {x[row] / scale:.3f} a_ref") for k, row in enumerate(rows)),
        columns=1,
    )


# ------------------------------------------------------------------------------------------------ the loads, and load over shift
def load_path(solution: ContactSolution, cycle: Cycle, chosen: Sequence[Event]) -> Plate:
    """The path in the P-Q plane: initial loading, cycle, Coulomb limit, chosen instants, a ring at the instant shown.

    Beneath it bulk stress, tilt and moment over the cycle, where there are any.
    """
    friction, unit = solution.scene.friction.coefficient, load_unit(solution.scene)
    path = solution.scene.load.path()
    periodic = path.period is not None
    parts = {"initial loading" if path.cycle else "path": path.initial_loading, "cycle": path.cycle}
    looks = {"initial loading": "initial-loading", "path": "loop", "cycle": "loop"}
    time, part = list[Array](), list[str]()
    for name, legs in parts.items():
        time += [sampled(leg, 257) for leg in legs]
        part += [name] * (sum(map(len, time)) - len(part))
    instants, names = np.concatenate(time), np.array(part)
    normal, tangential = (np.asarray(load) for load in path.at(instants))
    top = 1.08 * float(normal.max())
    reached = 1.25 * max(float(np.abs(tangential).max()), 0.15 * top)
    drawn = [name for name in parts if name in part]
    marks: list[Mark] = [Curve([0, top], [0, s * friction * top], "cone", "|Q| = f P") for s in (1, -1) if friction]
    marks += [Curve(normal[names == name], tangential[names == name], looks[name], name) for name in drawn]
    up = Axis(min(-0.3 * reached, 1.25 * float(tangential.min())), reached, f"tangential load Q  [{unit}]")
    across, alt = Axis(0.0, top, f"normal load P  [{unit}]"), "Load path in the plane of P and Q"
    panel = Panel("load-path", across, up, marks, alt, height=330.0)
    marks += _events(panel, cycle.normal_load, cycle.tangential_load, chosen)
    start = first_shown(cycle, chosen)
    marks.append(_follower("P", cycle.normal_load[start], cycle.tangential_load[start], "now"))
    beside = [_over_cycle(cycle, periodic, *pair) for pair in _bulk_and_tilt(solution.scene, cycle)]
    keys = (*(Key(looks[name], name) for name in reversed(drawn)), *([Key("cone", "|Q| = f P")] if friction else []))
    return Plate(
        "load_path",
        "Load path",
        "The numbers are the chosen instants, in the order of time; the ring is the instant shown."
        + (" Beneath: what is imposed beside P and Q, through the last cycle." if beside else ""),
        "Path of the loads in the plane of P and Q with the friction cone.",
        (panel, *(panel for panel, _ in beside)),
        {"time": instants, "part": part, "P": normal, "Q": tangential},
        (*keys, *(key for _, more in beside for key in more)),
        columns=1,
    )


def _bulk_and_tilt(scene: Scene, cycle: Cycle) -> Iterator[tuple[str, str, dict[str, Array]]]:
    """Name, words of the axis and lines, by their words, of what a scene has beside P and Q, each with its unit."""
    force, _, stress = units(scene)
    pulled = {f"σ, {name} body": getattr(cycle, f"bulk_stress_{name}") for name in ("lower", "upper")}
    pulled = {words: values for words, values in pulled.items() if values is not None and np.any(values)}
    if pulled:
        yield "bulk-stress", f"bulk stress σ  [{stress}]", pulled
    if cycle.tilt is not None and np.any(cycle.tilt):
        yield "tilt", "tilt α  [rad]", {"tilt of the upper body": cycle.tilt}
    if cycle.moment is not None and np.any(cycle.moment) and scene.load.moment_given:
        yield "moment", f"moment M  [{force}]", {"moment": cycle.moment}


def _over_cycle(cycle: Cycle, periodic: bool, name: str, words: str, lines: Mapping[str, Array]) -> tuple[Panel, tuple[Key, ...]]:
    """Series through the last cycle in a small panel, and their keys."""
    time, across = (cycle.fraction, "time / period") if periodic and cycle.whole else (cycle.time, "time")
    keys = tuple(Key(f"{look} fine", text) for look, text in zip(_IMPOSED[name], lines, strict=False))
    marks: list[Mark] = [Rule(0.0, "zero"), *(Curve(time, lines[key.text], key.css, key.text) for key in keys)]
    up = Axis(*limits(*lines.values(), zero=True, margin=0.12), words, count=3)
    return Panel(name, Axis(*limits(time, margin=0), across), up, marks, f"{words} over time", height=190.0, time="x"), keys


# Looks of the lines of each small panel beneath the load path.
_IMPOSED = {"bulk-stress": LINES[:2], "tilt": LINES[2:3], "moment": LINES[3:4]}


def _events(panel: Panel, across: Array, up: Array, chosen: Sequence[Event]) -> Iterator[Mark]:
    """Numbered dots, numbers outside the loop that the dots lie on; a number that would stand on another one is left out."""
    x, y = panel.frame.x.place(across), panel.frame.y.place(up)
    taken: list[Array] = []
    for number, event in enumerate(chosen, start=1):
        k, data = event.index, {"event": event.index}
        away = 13 * _outward(x, y, k)
        place = np.array([x[k], y[k]]) + away
        yield Dot(float(across[k]), float(up[k]), "event", 3.4, data=data)
        if all(np.hypot(*(place - other)) > 11 for other in taken):
            taken.append(place)
            yield Note(float(across[k]), float(up[k]), str(number), "number", "middle", (float(away[0]), float(away[1]) + 4), data)


def _outward(x: Array, y: Array, k: int) -> Array:
    """Unit vector across the line at its k-th place, away from the middle of all places."""
    before, after = max(k - 1, 0), min(k + 1, len(x) - 1)
    across = np.array([y[before] - y[after], x[after] - x[before]])
    from_middle = np.array([x[k] - x.mean(), y[k] - y.mean()])
    if not np.all(np.isfinite(across)) or not np.hypot(*across):
        across = from_middle
    across = -across if across @ from_middle < 0 else across
    return np.asarray(across / (np.hypot(*across) or 1.0))


def _follower(x: str, across: float, up: float, css: str) -> Dot:
    """A ring that the slider moves along Q over another series."""
    return Dot(float(across), float(up), f"follow {css}", 6.5, data={"series_x": x, "series_y": "Q"})


def hysteresis(comparison: Comparison, chosen: Sequence[Event]) -> Plate | None:
    """Tangential load over tangential displacement in the last cycle, both engines; beside it sheared, so that the loop opens.

    None where neither load nor shift moves, or the result holds no shift.
    """
    scene, expected, found = comparison.scene, comparison.expected, comparison.found
    series = (found.tangential_load, found.tangential_displacement, expected.tangential_displacement)
    if "tangential_displacement" in missing(comparison.result) or all(np.ptp(values) == 0 for values in series):
        return None
    load, length = load_unit(scene), units(scene)[1]
    slopes, area = " and ".join(signed(loop_compliance(cycle)) for cycle in (expected, found)), ""
    if scene.load.path().period is not None:
        # P works too where it varies and the approach hangs on Q as well.
        alone = are_half_planes(scene) or (np.ptp(found.normal_load) == 0 and found.tilt is None)
        area = ", which leaves the area as it is: "
        if comparison.pulled:
            area += _both_works(comparison)
        else:
            area += "the dissipation of the cycle" if alone else (
                "the work of Q in the cycle, which between half-planes of like materials is the dissipation; "
                "of these bodies P may work too (∮ P dV below)"
            )  # fmt: skip
    keys = tuple(Key(f"{who} p", name) for who, _, name in sides(comparison))
    loads = [expected.tangential_load, found.tangential_load]
    panels, start = [], first_shown(found, chosen)
    for name, words, letter, of in (
        ("hysteresis", f"tangential displacement U  [{length}]", "U", "stroke"),
        ("hysteresis-sheared", f"U − k Q, about its mean  [{length}]", "V", "width"),
    ):
        shifts = [sheared_shift(cycle) if letter == "V" else cycle.tangential_displacement for cycle in (expected, found)]
        stroke = float(np.ptp(shifts[0])) or 1.0
        note = measured(100 * (shifts[1] - shifts[0]) / stroke, found.fraction, "{}", " %").rpartition(" at ")[0]
        marks: list[Mark] = [Curve(u, q, key.css, key.text) for key, u, q in zip(keys, shifts, loads, strict=True)]
        across = Axis(*limits(*shifts, margin=0.12), words, count=4)
        up = Axis(*limits(*loads, margin=0.12), f"tangential load Q  [{load}]")
        notes = [f"{note}, of the {of}"] if note else []
        panel = Panel(name, across, up, marks, f"Tangential load over {words}", height=330.0, notes=notes)
        marks += _events(panel, shifts[1], loads[1], chosen)
        for n, css in enumerate(("now pale", "now")):
            marks.append(_follower(f"{letter}{n}", shifts[n][start], loads[n][start], css))
        panels.append(panel)
    bulk = [
        (bulk_strain(cycle, scene.material), cycle.shear_moment) for cycle in (expected, found) if cycle.shear_moment is not None
    ]
    if comparison.pulled and len(bulk) == 2:
        marks = [Curve(strain, moment, key.css, key.text) for key, (strain, moment) in zip(keys, bulk, strict=True)]
        across = Axis(*limits(*(strain for strain, _ in bulk), margin=0.12), "bulk strain ε = σ/E′, lower − upper", count=4)
        up = Axis(*limits(*(moment for _, moment in bulk), margin=0.12), f"moment of the shear m_q  [{units(scene)[0]}]")
        panels.append(Panel("bulk-loop", across, up, marks, "Moment of the shear over bulk strain", height=330.0))
    return Plate(
        "hysteresis",
        "Hysteresis loop",
        "First: shift of the upper body over the lower. Second: each less its own mean slope "
        f"(k = {slopes} {length} per {load}) and mean{area}.",
        "Tangential load over tangential displacement for both engines, as it is and sheared so that the loop opens.",
        tuple(panels),
        {
            "time": found.time,
            "Q": found.tangential_load,
            "U_reference": expected.tangential_displacement,
            "U_result": found.tangential_displacement,
        },
        keys,
    )


def _both_works(comparison: Comparison) -> str:
    """What the loop of Q over U is with bulk stress, and the other work, of reference and result."""
    cycles, materials = (comparison.expected, comparison.found), comparison.scene.material
    of_force, of_bulk, whole = (
        " and ".join(minus(f"{work:.5g}") for work in works)
        for works in (
            [loop_work(cycle) for cycle in cycles],
            [bulk_work(cycle, materials) for cycle in cycles],
            [comparison.reference.dissipation, comparison.result.dissipation],
        )
    )
    return (
        f"the work of Q in the cycle. With bulk stress that is not the dissipation: ∮ Q dU = {of_force}, −∮ m_q dε = {of_bulk}, "
        f"and W = {whole} {energy_unit(comparison.scene)} (reference and result). Third: the moment of the shear, m_q = ∫ x q dx, "
        "over the bulk strain; its area is the second of these works"
    )


def sheared_shift(cycle: Cycle) -> Array:
    """Shift less the mean slope times Q and less its mean: the loop keeps its area and opens."""
    shift = cycle.tangential_displacement - loop_compliance(cycle) * cycle.tangential_load
    return np.asarray(shift - shift.mean())


def loop_compliance(cycle: Cycle) -> float:
    """Slope dU/dQ of the straight line through the loop, least squares; 0 where Q stands still."""
    load = cycle.tangential_load - cycle.tangential_load.mean()
    square = float(load @ load)
    return float(load @ cycle.tangential_displacement) / square if square > 0 else 0.0


# ------------------------------------------------------------------------------------------------ checks that need no reference
def energy(solution: ContactSolution) -> Plate | None:
    """Every energy that the engine recorded, summed up over the path; None if it recorded none.

    `record.energy` holds what each step adds. The large ones (work of the loads, elastic energy) stand apart from the
    friction work, which would be a flat line beside them.
    """
    recorded = {name: np.cumsum(series) for name, series in solution.record.energy.items()}
    if not recorded:
        return None
    large = [name for name in recorded if name in ("external", "external_end_of_step", "elastic")]
    looks, panels, keys = dict(zip(recorded, LINES, strict=False)), [], []
    for number, group in enumerate((large, [name for name in recorded if name not in large])):
        keys += [Key(looks[name], name.replace("_", " ")) for name in group]
        marks = [*_cycles(solution), *(Curve(solution.time, recorded[n], looks[n], n.replace("_", " ")) for n in group)]
        if group:
            across = Axis(*limits(solution.time, margin=0), "time")
            up = Axis(*limits(*(recorded[n] for n in group)), f"energy since the start  [{energy_unit(solution.scene)}]")
            panels.append(Panel(f"energy-{number}", across, up, marks, "Energies over time", height=280.0))
    return Plate(
        "energy",
        f"Energy, {name_of(solution.engine)}",
        "Summed up from the start, per unit thickness; that external work = elastic energy + interface work at every step is "
        "one of the certificates. Friction work with the tractions at the end of each step (end of step) instead of "
        "their mean (interface) shows the error of the steps themselves.",
        "Energies over time.",
        tuple(panels),
        {"time": solution.time} | dict(solution.record.energy),
        tuple(keys),
    )


def certificates(role: str, solution: ContactSolution, checks: Sequence[Certificate]) -> Plate:
    """Violation of each law of contact at each instant of the whole path; those that are exactly 0 are only named.

    `role` is "reference" or "result": engines have names that no file could have.
    """
    shown = [check for check in checks if np.any(check.series != 0)]
    exact = [check.label for check in checks if check not in shown]
    finite = [float(s) for check in shown for s in check.series if np.isfinite(s)]
    keys = tuple(Key(f"{css} fine", check.label) for check, css in zip(shown, LINES, strict=False))
    lines: list[Mark] = [*_cycles(solution), Rule(LIMIT, "limit")]
    lines += [Curve(solution.time, check.series, key.css, check.label) for check, key in zip(shown, keys, strict=True)]
    lines.append(Note(float(solution.time[-1]), LIMIT, "limit", anchor="end", shift=(-4.0, -5.0)))
    title = f"Certificates, {name_of(solution.engine)}"
    across = Axis(*limits(solution.time, margin=0), "time", count=8)
    up = Axis(1e-18, 30 * max([LIMIT, *finite]), "violation, dimensionless", log=True)
    notes = [minus(f"largest {max(finite):.1e}, limit {LIMIT:.0e}")] if finite else []
    return Plate(
        f"certificates_{role}",
        title,
        "How far each law of contact is violated, where it is at all."
        + (f" Exactly 0 throughout: {', '.join(exact)}." if exact else ""),
        "Violations of the laws of contact over time on a logarithmic axis.",
        (_broad(f"certificates-{role}", across, up, lines, title, notes=notes),),
        {"time": solution.time} | {check.label: check.series for check in checks},
        keys,
        columns=1,
    )


def _cycles(solution: ContactSolution) -> list[Mark]:
    """A thin line where each cycle starts."""
    path = solution.scene.load.path()
    if path.period is None:
        return []
    starts = np.arange(path.cycle_start, solution.time[-1] + 1e-9 * path.period, path.period)
    return [Rule(float(start), "cycle-line", upright=True) for start in starts]


# --------------------------------------------------------------------------------------------- error budget, mesh convergence
# Height of a row [units of a drawing]; one that is so many times as long as the middle one is cut off, so that others can be read.
_ROW, _CUT = 44.0, 3.0


def bars(budget: ErrorBudget) -> Plate | None:
    """The terms of every metric that has a tolerance as a stack over it; None where no metric has one.

    What adds to the metric lies right of zero, what takes from it left: the two stacks together are E. Where the scene states no
    tolerance at all, the metrics of the first table in per cent.
    """
    judged = [one for one in budget.budgets if one.metric.tolerance]
    shown = judged or [one for one in budget.budgets if one.metric.definition.headline]
    if not shown:
        return None
    rest = "unexplained" if shown[0].half_planes else "idealisation"
    names = [*(term.name for term in shown[0].terms), rest]
    unit = "of the tolerance" if judged else "%"

    def over(one: Budget, value: float | None) -> float:
        found = (value or 0.0) / ((one.metric.tolerance or 1.0) if judged else 0.01)
        return found if math.isfinite(found) else 0.0

    stacks = [[over(one, part) for part in (*(term.value for term in one.terms), one.rest)] for one in shown]
    reaches = [
        max(
            sum(s for s in shares if s > 0),
            -sum(s for s in shares if s < 0),
            abs(over(one, one.total)) + over(one, one.uncertainty),
        )
        for one, shares in zip(shown, stacks, strict=True)
    ]
    wide = 1.08 * max(1.05 if judged else 0.0, min(max(reaches), _CUT * float(np.median(reaches))) or 1.0)
    marks: list[Mark] = []
    for row, (one, shares) in enumerate(zip(shown, stacks, strict=True)):
        low, ends = float(len(shown) - row - 1), {True: 0.0, False: 0.0}
        # Zero and the limits are drawn beside the bars alone: on a phone labels reach across them.
        for place, css in ((0.0, "zero"), *(((-1.0, "limit"), (1.0, "limit")) if judged else ())):
            marks.append(Segments(np.array([[[place, low + 0.06], [place, low + 0.56]]]), css))
        for k, (share, name) in enumerate(zip(shares, names, strict=True)):
            start = ends[share > 0]
            ends[share > 0] = start + share
            if share:
                label = minus(f"{name}: {share:+.3g} {unit}")
                marks.append(Block((start, start + share), (low + 0.14, low + 0.5), f"term-{k} edge", label))
        marks += _total(low, over(one, one.total), over(one, one.uncertainty), wide)
        beyond = ", cut off" if reaches[row] > wide else ""
        words = f"{one.metric.label}: {value_of(one.metric)}{beyond}"
        marks.append(Note(-wide, low + 0.7, words, "tick over", shift=(6.0, 0.0)))

    def numbers(values: Sequence[float | None]) -> list[float]:
        return [math.nan if value is None else value for value in values]

    across = Axis(-wide, wide, "share of the tolerance" if judged else "per cent", count=8)
    up = Axis(0.0, float(len(shown)), "", count=0)
    return Plate(
        "budget",
        "What every discrepancy is made of",
        ("Each term over the metric's tolerance (thin lines: ±1)" if judged else "Each term in per cent")
        + "; the black mark is the whole discrepancy E with its uncertainty. A row much longer than the others is cut off.",
        "Stacked bars: the terms of the error of every metric, over its tolerance.",
        (
            _broad(
                "budget", across, up, marks, "Error budget as stacked bars", _ROW * len(shown) + 60, room=(20.0, 12.0, 20.0, 46.0)
            ),
        ),
        {
            "metric": [one.metric.key for one in shown],
            "tolerance": numbers([one.metric.tolerance for one in shown]),
            "E": [one.total for one in shown],
            **{name: numbers([one.terms[k].value for one in shown]) for k, name in enumerate(names[:-1])},
            rest: [one.rest for one in shown],
            "u": numbers([one.uncertainty for one in shown]),
        },
        tuple(Key(f"term-{k}", name, patch=True) for k, name in enumerate(names)),
        columns=1,
    )


def _total(low: float, total: float, uncertainty: float, wide: float) -> Iterator[Mark]:
    """E as an upright mark with its uncertainty across it; a head at the edge where it goes on beyond."""
    middle = low + 0.32
    if abs(total) <= wide:
        yield Curve([total, total], [low + 0.06, low + 0.58], "total")
    left, right = max(total - uncertainty, -wide), min(total + uncertainty, wide)
    if right > left:
        yield Curve([left, right], [middle, middle], "whisker")
    for side in (-1, 1):
        if side * total + uncertainty > wide:
            tip, back = side * 0.998 * wide, side * 0.985 * wide
            yield Curve([back, tip, back], [middle - 0.1, middle, middle + 0.1], "whisker")


def ladders(budget: ErrorBudget) -> Plate | None:
    """|phi(h) - phi(0)| of the headline metrics over the element size; None for two meshes or where no metric converges."""
    rungs, curves = [rung for rung in budget.ladders.mesh if not rung.failure], {}
    for one in budget.budgets:
        values = [(rung.size, rung.values.get(one.metric.key)) for rung in rungs]
        points = [(size, float(value)) for size, value in values if value is not None and math.isfinite(value)]
        if one.metric.definition.headline and len(points) >= 3:
            found = extrapolate(Ladder(tuple(size for size, _ in points), tuple(value for _, value in points), 2.0, ROUNDING))
            if found.kind == "monotone" and found.value is not None:
                curves[one.metric.label] = [(size, abs(value - found.value)) for size, value in points if value != found.value]
    words = "element size, over that of the run", "distance from the value at size zero"
    caption = (
        "Each metric on coarser meshes, its distance from what the ladder extrapolates to; a metric that only scatters is left out."
    )
    return _convergence("ladders", "Mesh ladders", caption, words, curves, [rung.size for rung in rungs])


def distances(study: Study) -> Plate | None:
    """|E(h) - E(0)| of each headline metric that goes to a value, over the element size; None for two meshes or where none does."""
    sizes, curves = [level.size for level in study.levels], {}
    for line in study.lines:
        if line.metric.definition.headline and line.found.kind == "monotone" and (limit := line.found.value) is not None:
            curves[line.metric.label] = [(size, abs(value - limit)) for size, value in zip(sizes, line.values, strict=True)]
    words = "element size at the contact", "distance from the value at h = 0"
    caption = "Each metric on each mesh, its distance from what the meshes extrapolate to, but those that scatter or are exact."
    return _convergence("study", "How fast it converges", caption, words, curves, sizes)


def _convergence(
    name: str,
    title: str,
    caption: str,
    words: tuple[str, str],
    found: Mapping[str, list[tuple[float, float]]],
    used: Sequence[float],
) -> Plate | None:
    """Distances over the element size, both logarithmic, beside lines of order 1 and 2."""
    curves = {label: points for label, points in found.items() if any(height > 0 for _, height in points)}
    if len(used) < 3 or not curves:
        return None
    sizes = np.array(sorted(used))
    heights = [height for points in curves.values() for _, height in points if height > 0]
    top, marks, keys = max(heights), list[Mark](), []
    slopes = [Key(f"slope order-{order}", f"order {order}") for order in (1, 2)]
    marks += [Curve(sizes, top * (sizes / sizes[-1]) ** order, key.css, key.text) for order, key in enumerate(slopes, 1)]
    for (label, points), css in zip(curves.items(), LINES, strict=False):
        marks.append(Curve([h for h, _ in points], [height for _, height in points], css, label))
        marks += [Dot(h, height, f"{css} knot", 3.2) for h, height in points if height > 0]
        keys.append(Key(css, label))
    across = Axis(0.8 * float(sizes.min()), 1.25 * float(sizes.max()), words[0], log=True)
    # Below a millionth of the largest distance a curve is round-off.
    up = Axis(max(min(heights), 1e-6 * top) / 3, 3 * top, words[1], log=True)
    return Plate(
        name,
        title,
        caption,
        "Distances from the extrapolated values over the element size, both logarithmic, with lines of order one and two.",
        (_broad(name, across, up, marks, f"{title}, both axes logarithmic", 360.0),),
        {
            "metric": [label for label, points in curves.items() for _ in points],
            "size": [size for points in curves.values() for size, _ in points],
            "distance": [height for points in curves.values() for _, height in points],
        },
        (*keys, *slopes),
        columns=1,
    )
