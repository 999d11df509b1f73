"""Figures in the plane of the loads and of load over shift: load path and hysteresis loop, with their chosen instants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from reports.body_words import are_half_planes
from reports.charts import marks
from reports.charts.panel import Axis, frame, panel
from reports.charts.plate import Key, Plate
from reports.charts.scale import limits
from reports.comparison import Comparison
from reports.definitions import name_of
from reports.figures_cycle import sides
from reports.instants import Event
from reports.missing import missing
from reports.sampling import Cycle
from reports.units import load_unit, signed, units
from scenes import ContactSolution, sampled

Array = NDArray[np.float64]
_CSS = {"initial loading": "initial-loading", "path": "loop", "cycle": "loop"}


def first_shown(cycle: Cycle, chosen: Sequence[Event]) -> int:
    """The instant that a page shows first: of the chosen ones that with most points slipping, of equal ones the most loaded."""
    return max((event.index for event in chosen), key=lambda k: (int((cycle.state[k] >= 2).sum()), float(cycle.normal_load[k])))


def load_path(solution: ContactSolution, cycle: Cycle, chosen: Sequence[Event]) -> Plate:
    """The path in the P-Q plane: initial loading, cycle, friction cone, chosen instants."""
    time, part, normal, tangential = _path(solution)
    cone = (Key("cone", "|Q| = f P"),) if solution.scene.friction.coefficient else ()
    return Plate(
        "load_path",
        "Load path",
        "The numbers are the chosen instants, in the order of time; the ring is the instant shown.",
        "Path of the loads in the plane of P and Q with the friction cone.",
        (load_panel(solution, cycle, chosen, "load-path", 330.0),),
        {"time": time, "part": [str(p) for p in part], "P": normal, "Q": tangential},
        (*(Key(_CSS[name], name) for name in dict.fromkeys(part[::-1].tolist())), *cone),
        columns=1,
    )


def load_panel(solution: ContactSolution, cycle: Cycle, chosen: Sequence[Event], clip: str, height: float) -> str:
    """The drawing of the load path, `height` units high, with a ring at the instant shown first."""
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
    for name, css in _CSS.items():
        if (part == name).any():
            lines.append(marks.curve(area, normal[part == name], tangential[part == name], css, name))
    lines += _events(area, cycle.normal_load, cycle.tangential_load, chosen)
    start = first_shown(cycle, chosen)
    lines.append(_follower(area, "P", "Q", cycle.normal_load[start], cycle.tangential_load[start], "now"))
    return panel(area, *axes, lines, "Load path in the plane of P and Q", clip=clip)


def _path(solution: ContactSolution) -> tuple[Array, NDArray[np.str_], Array, Array]:
    """Times, the part they belong to, P and Q all along the path."""
    path = solution.scene.load.path()
    legs = [(leg, "initial loading" if path.cycle else "path") for leg in path.initial_loading] + [
        (leg, "cycle") for leg in path.cycle
    ]
    samples = [(sampled(leg, 257), part) for leg, part in legs]
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
    if "tangential_displacement" in missing(comparison.result):
        return False
    expected, found = comparison.expected, comparison.found
    return any(
        np.ptp(series) != 0 for series in (found.tangential_load, found.tangential_displacement, expected.tangential_displacement)
    )


def hysteresis(comparison: Comparison, chosen: Sequence[Event]) -> Plate | None:
    """Tangential load over tangential displacement in the last cycle, both engines; beside it sheared, so that the loop opens.

    None where neither load nor shift moves.
    """
    if not moves(comparison):
        return None
    load, length = load_unit(comparison.scene), units(comparison.scene)[1]
    slopes = " and ".join(signed(loop_compliance(cycle)) for cycle in (comparison.expected, comparison.found))
    area = "" if comparison.scene.load.path().period is None else f", which leaves the area as it is: {_area(comparison)}"
    return Plate(
        "hysteresis",
        "Hysteresis loop",
        "First: shift of the upper body over the lower. Second: each less its own mean slope "
        f"(k = {slopes} {length} per {load}) and mean{area}.",
        "Tangential load over tangential displacement for both engines, as it is and sheared so that the loop opens.",
        tuple(
            hysteresis_panel(comparison, chosen, clip, sheared=sheared)
            for clip, sheared in (("hysteresis", False), ("hysteresis-sheared", True))
        ),
        {
            "time": comparison.found.time,
            "Q": comparison.found.tangential_load,
            "U_reference": comparison.expected.tangential_displacement,
            "U_result": comparison.found.tangential_displacement,
        },
        tuple(Key(f"{w} p", name_of(s.engine)) for w, _, s in sides(comparison)),
    )


def _area(comparison: Comparison) -> str:
    """What the area of the loop is; P works too where it varies and the approach hangs on Q as well."""
    if are_half_planes(comparison.scene) or np.ptp(comparison.found.normal_load) == 0:
        return "the dissipation of the cycle"
    return (
        "the work of Q in the cycle, which between half-planes of like materials is the dissipation; "
        "of these bodies P may work too (∮ P dV below)"
    )


def hysteresis_panel(comparison: Comparison, chosen: Sequence[Event], clip: str, *, sheared: bool) -> str:
    """Q over the shift of both engines; `sheared`: over the shift less its mean slope, so that the loop opens."""
    length, series = units(comparison.scene)[1], "V" if sheared else "U"
    words = f"U − k Q, about its mean  [{length}]" if sheared else f"tangential displacement U  [{length}]"
    cycles = sides(comparison)
    shifts = [(sheared_shift(cycle) if sheared else cycle.tangential_displacement) for _, cycle, _ in cycles]
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
    start = first_shown(comparison.found, chosen)
    for number, (shift, load, css) in enumerate(zip(shifts, loads, ("now pale", "now"), strict=True)):
        lines.append(_follower(area, f"{series}{number}", "Q", shift[start], load[start], css))
    return panel(area, *axes, lines, f"Tangential load over {words}", clip=clip)


def sheared_shift(cycle: Cycle) -> Array:
    """Shift less the mean slope times Q and less its mean: the loop keeps its area and opens."""
    shift = cycle.tangential_displacement - loop_compliance(cycle) * cycle.tangential_load
    return np.asarray(shift - shift.mean())


def loop_compliance(cycle: Cycle) -> float:
    """Slope dU/dQ of the straight line through the loop, least squares; 0 where Q stands still."""
    load = cycle.tangential_load - cycle.tangential_load.mean()
    square = float(load @ load)
    return float(load @ cycle.tangential_displacement) / square if square > 0 else 0.0
