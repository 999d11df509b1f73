"""Figures over x: tractions at chosen instants and at the one shown, the map of states, pointwise dissipation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Axis, Bitmap, Block, Curve, Dot, Group, Mark, Note, Rule
from reports.charts.plate import STATE_KEYS, Cell, Key, Panel, Plate
from reports.charts.scale import limits
from reports.charts.style import STATE_NAMES
from reports.comparison import Comparison
from reports.comparison.cycles import Cycle, Event
from reports.comparison.metrics import name_of
from reports.comparison.words import value_of
from reports.units import minus, signed
from scenes import ContactSolution

Array = NDArray[np.float64]
X = "x / a_ref"
# Open, stick, forward and reverse slip on a map, which has no style sheet.
_STATES = ("#ffffff", "#d2d2d2", "#e69f00", "#0072b2")
_COLUMNS, _ROWS = 440, 360
# Rows of the table of states: of a long path evenly many instants, 25 MB.
_MOST_STATES = 500_000


def sides(comparison: Comparison) -> tuple[tuple[str, Cycle, ContactSolution], ...]:
    """Look of its lines, last cycle and answer: of the reference, then of the result."""
    return ("r", comparison.expected, comparison.reference), ("f", comparison.found, comparison.result)


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


def traction_keys(comparison: Comparison) -> tuple[Key, ...]:
    """The legend of a figure of tractions."""
    theirs, ours = name_of(comparison.reference.engine), name_of(comparison.result.engine)
    lines = (("r p", f"p, {theirs}"), ("r q", f"q, {theirs}"), ("f p", f"p, {ours}"), ("f q", f"q, {ours}"))
    return tuple(Key(css, text) for css, text in (*lines, ("d p", "difference of p"), ("d q", "difference of q")))


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
    both = {key: [getattr(cycle, field)[grid] / size for cycle in (expected, found)] for key, (field, size) in fields.items()}
    apart = {key: 100 * (pair[1] - pair[0]) for key, pair in both.items()}
    across = Axis(-wide, wide, "")
    up = Axis(*limits(*(series for pair in both.values() for series in pair), zero=True), "p/p_ref,  q/(f p_ref)")
    below = Axis(*limits(*apart.values(), zero=True, least=1e-9), "difference, %", count=3)
    touching = (both["p"][0][0] != 0) | (both["p"][1][0] != 0)
    engines = (("r", comparison.reference), ("f", comparison.result))
    lines: list[Mark] = [Rule(0.0, "zero")]
    lines += [
        Curve(
            x[near],
            both[key][n][0].copy(),
            f"{who} {key}",
            f"{key}, {name_of(solution.engine)}",
            {"field": f"{key}{n}"} if live else {},
        )
        for n, (who, solution) in enumerate(engines)
        for key in "pq"
    ]
    differences: list[Mark] = [Rule(0.0, "zero")]
    differences += [
        Curve(x[near], apart[key][0].copy(), f"d {key}", f"difference of {key}, %", {"field": f"d{key}"} if live else {})
        for key in "pq"
    ]
    notes = [f"{key}: {measured(apart[key][0], x[near], 'x = {} a_ref', ' %', touching)}" for key in "pq"]
    room = (72.0, 26.0 if title else 12.0, 20.0, 20.0)
    return (
        Panel(name, across, up, lines, f"Pressure and shear over x. {title}".strip(), width, height, title, room=room),
        Panel(
            f"{name}-difference",
            Axis(-wide, wide, X),
            below,
            differences,
            f"Result less reference over x. {title}".strip(),
            width,
            0.56 * height + 56,
            notes=notes,
        ),
    )


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
    for number, (_, cycle, solution) in enumerate(sides(comparison)):
        top = 20.0 + 40.0 * number
        x = cycle.x / comparison.scales.half_width
        turns = np.flatnonzero(np.diff(cycle.state[k]))
        ends = [-wide, *np.clip((x[turns + 1] + x[turns]) / 2, -wide, wide).tolist(), wide]
        states = cycle.state[k, [0, *(turns + 1).tolist()]].tolist()
        runs = zip(ends[:-1], ends[1:], states, strict=True)
        blocks = tuple(Block((a, b), (top, top + 16), f"state-{s}") for a, b, s in runs if b > a)
        marks += [
            Note(-wide, top - 5, name_of(solution.engine)),
            Group(blocks, "strip", {"strip": number, "top": f"{top:g}"}),
            Block((-wide, wide), (top, top + 16), "outline"),
        ]
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
    of = "" if len(written) == len(time) else f" The CSV holds {len(written)} of the {len(time)} instants."
    metric = comparison.metric("state")
    # The metric's own number: points crowd at the edges, so that counting them would give another, larger share.
    share = "" if metric.value is None else f"{value_of(metric)} of the length in contact"
    maps = (
        (expected.state, _STATES, name_of(comparison.reference.engine), "map-reference"),
        (found.state, _STATES, name_of(comparison.result.engine), "map-result"),
        (
            expected.state != found.state,
            ("#ffffff", "#111111"),
            f"they differ: {value_of(metric)}" if share else "they differ",
            "map-difference",
        ),
    )
    codes = ", ".join(f"{int(state)} {name}" for state, name in STATE_NAMES.items())
    return Plate(
        "state_map",
        "Stick and slip over x and time",
        "State of each surface point at each instant of the last cycle; time runs upwards."
        + (f" They differ over {share}, in the mean over time." if share else "")
        + of,
        "Two maps of open, stick, forward slip and reverse slip over x and time, one for each engine, and a third of "
        "their difference.",
        tuple(
            Panel(
                name,
                Axis(-wide, wide, X),
                Axis(*limits(time, margin=0), time_words),
                [Bitmap(states[np.ix_(rows, columns)].astype(np.uint8), palette)],
                f"Map of states: {words}",
                340.0,
                320.0,
                words,
                time="y",
                css="pick",
            )
            for states, palette, words, name in maps
        ),
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
    if not (np.any(comparison.expected.dissipation_density) or np.any(comparison.found.dissipation_density)):
        return None
    scales, x, wide = comparison.scales, comparison.found.x / comparison.scales.half_width, reach(comparison)
    unit = scales.dissipation / scales.half_width
    theirs, ours = comparison.expected.dissipation_density / unit, comparison.found.dissipation_density / unit
    across = Axis(-wide, wide, X)
    stick = comparison.reference.permanent_stick_half_width / scales.half_width
    lines: list[Mark] = [Rule(side * float(stick), "stick-line", upright=True) for side in (-1, 1) if np.isfinite(stick)]
    engines = (("r", theirs, comparison.reference), ("f", ours, comparison.result))
    lines += [Curve(x, w, f"{who} p", name_of(solution.engine)) for who, w, solution in engines]
    peak = int(np.nanargmax(np.where(np.isfinite(ours), ours, -np.inf)))
    lines.append(Dot(float(x[peak]), float(ours[peak]), "event"))
    apart = 100 * (ours - theirs) / (float(np.nanmax(np.abs(theirs), initial=0.0)) or 1.0)
    note = measured(apart, x, "x = {} a_ref", " %", (np.abs(x) <= wide) & ((theirs != 0) | (ours != 0)))
    stuck = f"; dashed: edges of the permanent stick zone, ±{stick:.4g} a_ref" if np.isfinite(stick) else ""
    return Plate(
        "dissipation_density",
        "Dissipation, point by point",
        "First: friction work per unit area in the last cycle. Dot: the peak, "
        f"{ours[peak]:.4g} at x = {signed(float(x[peak]))} a_ref{stuck}. Second: result − reference, over the largest reference.",
        "Dissipation density over x for both engines, and the difference.",
        (
            Panel(
                "work", across, Axis(*limits(theirs, ours, zero=True), "w / (A f² P_ref²/a_ref)"), lines,
                "Dissipation density over x", css="pick",
            ),
            Panel(
                "work-difference", across, Axis(*limits(apart, zero=True, least=1e-9), "difference, % of the largest"),
                [Rule(0.0, "zero"), Curve(x, apart, "d p", "difference")], "Difference of the dissipation density", notes=[note],
            ),
        ),
        {
            "x": comparison.found.x,
            "x/a_ref": x,
            "w_reference/(A f^2 P_ref^2/a_ref)": theirs,
            "w_result/(A f^2 P_ref^2/a_ref)": ours,
        },
        (*(Key(f"{who} p", name_of(solution.engine)) for who, _, solution in engines), Key("d p", "difference")),
    )  # fmt: skip
