"""Figures through the cycle: edges, errors and slip over time; the path of the loads and the hysteresis loop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Axis, Curve, Dot, Mark, Note, Rule
from reports.charts.plate import Key, Panel, Plate
from reports.charts.scale import limits
from reports.comparison import Comparison
from reports.comparison.cycles import Cycle, Event
from reports.comparison.metrics import are_half_planes, missing, name_of
from reports.figures_fields import first_shown, measured, sides
from reports.units import load_unit, minus, signed, units
from scenes import ContactSolution, sampled
from scenes.scene import OWN_TOLERANCES

Array = NDArray[np.float64]
LINES = tuple(f"line-{k}" for k in range(7))
_PARTS = {"initial loading": "initial-loading", "path": "loop", "cycle": "loop"}


# ------------------------------------------------------------------------------------------------------------------ over time
def half_widths(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Contact and stick edges of both engines through the last cycle, the difference of the half-widths beside them."""
    length, cycles = comparison.scales.half_width, sides(comparison)
    edges = (("contact_edges", "p", "contact edge"), ("stick_edges", "q", "stick edge"))
    across = Axis(*limits(time, margin=0), time_words)
    lines = [
        Curve(time, getattr(cycle, name)[:, side] / length, f"{who} {css}", f"{label}, {name_of(solution.engine)}")
        for who, cycle, solution in cycles
        for name, css, label in edges
        for side in (0, 1)
    ]
    halves = {name: [np.ptp(getattr(cycle, name), axis=1) / 2 / length for _, cycle, _ in cycles] for name, _, _ in edges}
    apart = {label.split()[0]: halves[name][1] - halves[name][0] for name, _, label in edges}
    x = comparison.found.x
    outer = float(np.nanmax(np.abs(comparison.found.contact_edges), initial=0.0))
    spacing = float(np.median(np.diff(x)[np.abs(np.abs(x[1:]) - outer) < 0.3 * (outer or np.inf)])) / length if outer else np.nan
    noise = (
        f" Ripples up to about {spacing:.1g} a_ref are noise of the mesh: so far apart are the points at the edge."
        if np.isfinite(spacing)
        else ""
    )
    title = "Contact and stick edges through the cycle"
    return Plate(
        "half_widths",
        title,
        "First: where contact and stick end. Second: half the distance between the edges, result − reference. In full stick "
        f"the stick edges are the contact edges; in full slip there are none.{noise}",
        "Contact and stick edges over time for both engines, and the difference of the half-widths.",
        (
            Panel("edges", across, Axis(*limits(*(line.y for line in lines)), "x / a_ref"), lines, title, time="x"),
            Panel(
                "edges-difference",
                across,
                Axis(*limits(*apart.values(), zero=True, least=1e-12), "difference of half-widths / a_ref"),
                [Rule(0.0, "zero"), *(Curve(time, apart[k], f"d {css}", k) for k, css in (("contact", "p"), ("stick", "q")))],
                "Difference of the half-widths",
                notes=[f"{k}: {measured(values, time, _when(time_words), ' a_ref')}" for k, values in apart.items()],
                time="x",
            ),
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


def _when(time_words: str) -> str:
    """Where a time stands in a sentence."""
    return "t/T = {}" if "period" in time_words else "t = {}"


def errors(comparison: Comparison, time: Array, time_words: str) -> Plate:
    """Metrics that have a value at each instant, at the instants that are judged: over their tolerances, where there are any.

    Where no tolerance was given, those that half-planes are judged by, in per cent.
    """
    series = [m for m in comparison.metrics if m.series is not None]
    judged = [m for m in series if m.tolerance is not None]
    shown = judged or [m for m in series if m.key in OWN_TOLERANCES]
    sizes = {
        m.key: np.where(comparison.judged, np.abs(np.asarray(m.series)) / (m.tolerance or (1.0 if judged else 0.01)), np.nan)
        for m in shown
    }
    worst = {key: int(np.nanargmax(size)) if np.isfinite(size).any() else 0 for key, size in sizes.items()}
    largest = max((float(np.nanmax(size, initial=0.0)) for size in sizes.values()), default=1.0)
    most = min(max(1.0, largest), 8.0) if judged else largest or 1.0
    lines: list[Mark] = [Rule(1.0, "limit")] if judged else []
    lines += [Curve(time, sizes[m.key], css, m.label) for m, css in zip(shown, LINES * 3, strict=False)]
    if judged:
        lines.append(Note(float(time[-1]), 1.0, "tolerance", anchor="end", shift=(-4.0, -5.0)))
    unit = "" if judged else " %"
    beyond = " Curves above 8 are cut off: their values are in the CSV." if judged and largest > 8 else ""
    over = "Each metric over its own tolerance, at the instants that are judged: above 1 it fails." if judged else (
        "Each metric in per cent of its scale, at the instants that are judged; no tolerance was given."
    )  # fmt: skip
    panel = Panel(
        "errors",
        Axis(*limits(time, margin=0), time_words, count=8),
        Axis(0.0, 1.08 * most, "|discrepancy| / tolerance" if judged else "|discrepancy|, %"),
        lines,
        "Discrepancy through the cycle",
        900.0,
        280.0,
        time="x",
        css="broad",
    )
    return Plate(
        "errors",
        "Discrepancy through the cycle",
        f"{over}{beyond} The legend has the largest value and its time. Steps from node to node are noise of the mesh.",
        "Discrepancies over their tolerances through the last cycle.",
        (panel,),
        {"time": comparison.found.time} | {m.key: np.asarray(m.series) for m in shown},
        tuple(
            Key(css, minus(f"{m.label}: {sizes[m.key][worst[m.key]]:.2g}{unit} at {time[worst[m.key]]:.3g}"))
            for m, css in zip(shown, LINES * 3, strict=False)
        ),
        columns=1,
    )


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
    lines = [
        Curve(
            time,
            slips[who][:, k],
            f"{'wide' if who == 'r' else 'thin'} point-{k}",
            f"x = {comparison.found.x[row] / scale:.3f} a_ref, {name_of(solution.engine)}",
        )
        for who, _, solution in cycles
        for k, row in enumerate(rows)
    ]
    apart = slips["f"] - slips["r"]
    point = int(np.argmax(np.nanmax(np.abs(np.nan_to_num(apart)), axis=0)))
    panel = Panel(
        "slip",
        Axis(*limits(time, margin=0), time_words, count=8),
        Axis(*limits(*slips.values(), zero=True, least=1e-12 * scale), f"slip since the start  [{length}]"),
        lines,
        "Slip of chosen points over time",
        900.0,
        320.0,
        notes=[
            f"result − reference at x = {comparison.found.x[rows[point]] / scale:.3f} a_ref, where it is largest:",
            measured(apart[:, point], time, _when(time_words), f" {length}"),
        ],
        time="x",
        css="broad",
    )
    return Plate(
        "slip_history",
        "Slip of chosen points",
        "Upper body over the lower, counted from the start of the cycle; it goes on as relative displacement while a point is "
        "open. Broad pale line: reference; thin dark line: result.",
        "Slip over time of a few points of the surface, for both engines.",
        (panel,),
        {"time": comparison.found.time}
        | {
            f"slip_{who}(x = {comparison.found.x[row]:.6g}) [{length}]": cycle.slip[:, row] - cycle.slip[0, row]
            for row in rows
            for who, cycle in (("reference", comparison.expected), ("result", comparison.found))
        },
        tuple(Key(f"point-{k}", f"x = {comparison.found.x[row] / scale:.3f} a_ref") for k, row in enumerate(rows)),
        columns=1,
    )


# ------------------------------------------------------------------------------------------------- the loads, and load over shift
def load_path(solution: ContactSolution, cycle: Cycle, chosen: Sequence[Event]) -> Plate:
    """The path in the P-Q plane: initial loading, cycle, Coulomb limit, chosen instants, a ring at the instant shown."""
    friction, unit = solution.scene.friction.coefficient, load_unit(solution.scene)
    path = solution.scene.load.path()
    parts = [(leg, "initial loading" if path.cycle else "path") for leg in path.initial_loading]
    samples = [(sampled(leg, 257), part) for leg, part in [*parts, *((leg, "cycle") for leg in path.cycle)]]
    time = np.concatenate([t for t, _ in samples])
    part = np.concatenate([np.full(len(t), name) for t, name in samples])
    normal, tangential = (np.asarray(load) for load in path.at(time))
    top = 1.08 * float(normal.max())
    reach = 1.25 * max(float(np.abs(tangential).max()), 0.15 * top)
    marks: list[Mark] = [Curve([0, top], [0, s * friction * top], "cone", "|Q| = f P") for s in (1, -1) if friction]
    marks += [Curve(normal[part == n], tangential[part == n], css, n) for n, css in _PARTS.items() if (part == n).any()]
    up = Axis(min(-0.3 * reach, 1.25 * float(tangential.min())), reach, f"tangential load Q  [{unit}]")
    panel = Panel(
        "load-path", Axis(0.0, top, f"normal load P  [{unit}]"), up, marks, "Load path in the plane of P and Q", height=330.0
    )
    marks += _events(panel, cycle.normal_load, cycle.tangential_load, chosen)
    start = first_shown(cycle, chosen)
    marks.append(_follower("P", "Q", cycle.normal_load[start], cycle.tangential_load[start], "now"))
    cone = (Key("cone", "|Q| = f P"),) if friction else ()
    return Plate(
        "load_path",
        "Load path",
        "The numbers are the chosen instants, in the order of time; the ring is the instant shown.",
        "Path of the loads in the plane of P and Q with the friction cone.",
        (panel,),
        {"time": time, "part": [str(p) for p in part], "P": normal, "Q": tangential},
        (*(Key(_PARTS[name], name) for name in dict.fromkeys(part[::-1].tolist())), *cone),
        columns=1,
    )


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
    if across @ from_middle < 0:
        across = -across
    return np.asarray(across / (np.hypot(*across) or 1.0))


def _follower(x: str, y: str, across: float, up: float, css: str) -> Dot:
    """A ring that the slider moves along two series."""
    return Dot(float(across), float(up), f"follow {css}", 6.5, data={"series_x": x, "series_y": y})


def hysteresis(comparison: Comparison, chosen: Sequence[Event]) -> Plate | None:
    """Tangential load over tangential displacement in the last cycle, both engines; beside it sheared, so that the loop opens.

    None where neither load nor shift moves, or the result holds no shift.
    """
    expected, found, cycles = comparison.expected, comparison.found, sides(comparison)
    series = (found.tangential_load, found.tangential_displacement, expected.tangential_displacement)
    if "tangential_displacement" in missing(comparison.result) or all(np.ptp(values) == 0 for values in series):
        return None
    load, length = load_unit(comparison.scene), units(comparison.scene)[1]
    slopes = " and ".join(signed(loop_compliance(cycle)) for cycle in (expected, found))
    area = ""
    if comparison.scene.load.path().period is not None:
        # P works too where it varies and the approach hangs on Q as well.
        area = ", which leaves the area as it is: " + (
            "the dissipation of the cycle"
            if are_half_planes(comparison.scene) or np.ptp(found.normal_load) == 0
            else "the work of Q in the cycle, which between half-planes of like materials is the dissipation; "
            "of these bodies P may work too (∮ P dV below)"
        )
    panels, start = [], first_shown(found, chosen)
    for name, words in (
        ("hysteresis", f"tangential displacement U  [{length}]"),
        ("hysteresis-sheared", f"U − k Q, about its mean  [{length}]"),
    ):
        sheared = name != "hysteresis"
        shifts = [sheared_shift(cycle) if sheared else cycle.tangential_displacement for _, cycle, _ in cycles]
        loads = [cycle.tangential_load for _, cycle, _ in cycles]
        apart, stroke = shifts[1] - shifts[0], float(np.ptp(shifts[0])) or 1.0
        note = measured(100 * apart / stroke, found.fraction, "{}", " %").rpartition(" at ")[0]
        marks: list[Mark] = [
            Curve(shift, q, f"{who} p", name_of(s.engine)) for (who, _, s), shift, q in zip(cycles, shifts, loads, strict=True)
        ]
        panel = Panel(
            name,
            Axis(*limits(*shifts, margin=0.12), words, count=4),
            Axis(*limits(*loads, margin=0.12), f"tangential load Q  [{load}]"),
            marks,
            f"Tangential load over {words}",
            height=330.0,
            notes=[f"{note}, of the {'width' if sheared else 'stroke'}"] if note else [],
        )
        marks += _events(panel, shifts[1], loads[1], chosen)
        for n, (shift, q, css) in enumerate(zip(shifts, loads, ("now pale", "now"), strict=True)):
            marks.append(_follower(f"{'V' if sheared else 'U'}{n}", "Q", shift[start], q[start], css))
        panels.append(panel)
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
        tuple(Key(f"{who} p", name_of(s.engine)) for who, _, s in cycles),
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
