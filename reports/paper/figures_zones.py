"""Figures 4, 5 and 8 of the paper: contact and stick through the cycle, and what four points of the surface do."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Band, Curve, Mark
from reports.charts.plate import Key, Panel, Plate
from reports.paper.cases import FRICTIONS, POINTS, Case
from reports.paper.figures_loads import LOAD, PALE_FORWARD, PALE_REVERSE, PALE_STICK
from reports.paper.plots import FAMILY, axes, line, named, plate
from scenes import SurfaceState

Array = NDArray[np.float64]

_ANGLE = "angle θ of the cycle after M  [degrees]"
_POINTS = ("d", "4", "3", "5")
_DEGREES = tuple((float(angle), f"{angle}") for angle in range(0, 361, 45))
_STATES = (
    Key("faint solid", "sticking"),
    Key("forward broad-line", "slipping forward"),
    Key("reverse broad-line", "slipping in reverse"),
    Key("faint dot", "separated"),
)


@dataclass(frozen=True, eq=False)
class Stretch:
    """Half-widths between two turning points of slip; at its start all sticks. Widths over a0."""

    direction: int
    time: Array
    contact: Array
    stick: Array


def stretches(case: Case, marks: Sequence[tuple[float, int]], count: int = 91) -> list[Stretch]:
    """The stretches between marks (time, direction of slip up to the next)."""
    found = []
    for (begin, direction), (end, _) in pairwise(marks):
        time = np.linspace(begin, end, count)
        solution = case.solve(time=time)
        contact, stick = solution.contact_half_width / case.length, solution.stick_half_width / case.length
        # An instant between two stretches belongs to the one that ends there, but here to the one that starts.
        stick = np.concatenate([contact[:1], stick[1:]])
        found.append(Stretch(direction, time, contact, stick))
    return found


def zone_parts(parts: Sequence[Stretch], horizontal: Sequence[Array]) -> Iterator[Mark]:
    """Stick and slip filled, both edges drawn."""
    joined, stick = np.concatenate(list(horizontal)), np.concatenate([s.stick for s in parts])
    yield Band(joined, np.zeros(len(joined)), stick, PALE_STICK, "stick")
    for stretch, x in zip(parts, horizontal, strict=True):
        if stretch.direction:
            colour, label = (PALE_FORWARD, "forward slip") if stretch.direction > 0 else (PALE_REVERSE, "reverse slip")
            yield Band(x, stretch.stick, stretch.contact, colour, label)
    yield line(joined, np.concatenate([s.contact for s in parts]), "contact, a / a(P₀)", "bold")
    yield line(joined, stick, "stick, c / a(P₀)", "c2 dash")


def figure_4a(case: Case) -> Plate:
    """Half-widths over the way that P has gone."""
    begin = case.scene.load.path().start
    marks = [(begin, 0), *((case.time(letter), way) for letter, way in zip("BEGIM", (1, -1, 0, 1, 0), strict=True))]
    # P turns at C, F and K: finer than that nothing is needed, since the way of P is taken from the instants.
    found = stretches(case, marks, 181)
    walked, far = [], 0.0
    for stretch in found:
        p = case.loads(stretch.time)[0]
        walked.append(far + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(p)))]))
        far = float(walked[-1][-1])
    places = _letter_places(case, found, walked)
    parts = list(zone_parts(found, walked))
    for letter, place in places.items():
        height = float(case.width(case.events[letter].normal_load))
        parts += named(place, height, letter, (0.0, 9.0), dot=True)
    load = {letter: case.events[letter].normal_load / case.unit for letter in "ACDFHKLM"}
    ticks = [(0.0, "0"), *((float(value), f"{value}") for value in (1, 2))]
    ticks += [(places[letter], f"{value:.3g}") for letter, value in load.items()]
    words = f"normal load P {LOAD}, along its path"
    across, up = axes((0.0, far + 0.05, words), (0.0, 1.3, "half-width / a(P₀)"), tuple(ticks))
    panel = Panel("figure_04a", across, up, parts, "Half-widths over the path of P", 820.0, 420.0)
    return plate(
        "figure_04a",
        "Figure 4a. Half-widths of contact and stick over the path of P, Hertz",
        "The abscissa is the way that P has gone, growing to C, falling to F, growing to K, falling to M. Slip is "
        "deeper in the first cycle (B to E) "
        "than in the steady state, as deep in reverse slip (E to G) as in forward slip (I to M), and there is none from G to I. "
        "At E, G and M the whole contact sticks at once.",
        "Contact and stick half-width over the progress of the normal load, slip shaded by its direction.",
        [panel],
        _stretch_table(case, found, {"way of P / (P0/3)": np.concatenate(walked)}),
    )


def _letter_places(case: Case, found: Sequence[Stretch], walked: Sequence[Array]) -> dict[str, float]:
    time, way = np.concatenate([s.time for s in found]), np.concatenate(list(walked))
    return {letter: float(np.interp(case.time(letter), time, way)) for letter in sorted(case.events)}


def _stretch_table(case: Case, found: Sequence[Stretch], first: dict[str, Array]) -> dict[str, Array]:
    time = np.concatenate([stretch.time for stretch in found])
    return first | {
        "t": time,
        "P / (P0/3)": case.loads(time)[0],
        "a / a(P0)": np.concatenate([stretch.contact for stretch in found]),
        "c / a(P0)": np.concatenate([stretch.stick for stretch in found]),
        "direction of slip": np.concatenate([np.full(len(s.time), s.direction) for s in found]),
    }


def steady_marks(case: Case) -> list[tuple[float, int]]:
    """Turning points of slip of a steady revolution from M on."""
    turn = 2 * math.pi
    return [
        (case.time("M"), -1),
        (case.time("G") + turn, 0),
        (case.time("I") + turn, 1),
        (case.time("M") + turn, 0),
    ]


def _angles(found: Sequence[Stretch], start: float) -> list[Array]:
    return [np.degrees(stretch.time - start) for stretch in found]


def figure_4b(case: Case) -> Plate:
    """Half-widths through the steady cycle for four coefficients of friction, about Q0 = 0."""
    others = {f: case.about_no_shear(f) for f in FRICTIONS}
    start = others[FRICTIONS[0]].time("M")
    parts: list[Mark] = []
    columns: dict[str, Array] = {}
    # Just after M, for f = 1 the instant of M itself still belongs to forward slip.
    grid = np.linspace(1e-6, 360.0, 721)
    parts += _shading(others[FRICTIONS[-1]], start)
    for number, (f, other) in enumerate(others.items()):
        solution = other.solve(time=start + np.radians(grid))
        columns |= {f"c / a(P0), f = {f}": solution.stick_half_width / other.length}
        parts.append(line(grid, columns[f"c / a(P0), f = {f}"], f"c / a(P₀), f = {f}", FAMILY[number]))
    contact = case.width(others[FRICTIONS[0]].solve(time=start + np.radians(grid)).normal_load)
    parts.append(line(grid, contact, "contact, a / a(P₀)", "bold"))
    words = "angle θ of the cycle after M for f = 1  [degrees]"
    across, up = axes((0.0, 360.0, words), (0.0, 1.3, "half-width / a(P₀)"), _DEGREES)
    panel = Panel("figure_04b", across, up, parts, "Half-widths over the angle", 700.0, 430.0)
    return plate(
        "figure_04b",
        "Figure 4b. Half-widths of contact and stick in the steady cycle, four coefficients of friction",
        "Drawn for Q₀ = 0: with Q₀ = 1.1 the loads would slide grossly at f = 0.6 and 0.4, and the extent of slip does not depend "
        "on Q₀. Shaded for f = 0.4. With more friction slip starts later, reverse and forward, and full stick returns earlier.",
        "Contact half-width and four stick half-widths over the angle of the cycle.",
        [panel],
        {"theta [degrees]": grid, "a / a(P0)": contact} | columns,
    )


def _shading(case: Case, start: float) -> list[Mark]:
    """Stick and slip of one coefficient of friction over the angle after `start`, filled."""
    parts: list[Mark] = []
    stick: list[tuple[Array, Array]] = []
    f = f"f = {case.friction:g}"
    for stretch in stretches(case, _two_turns(case)):
        angle = np.degrees(stretch.time - start)
        inside = (angle >= 0) & (angle <= 360)
        stick.append((angle[inside], stretch.stick[inside]))
        if stretch.direction and inside.any():
            colour, label = (PALE_FORWARD, "forward slip") if stretch.direction > 0 else (PALE_REVERSE, "reverse slip")
            parts.append(Band(angle[inside], stretch.stick[inside], stretch.contact[inside], colour, f"{label}, {f}"))
    angles, edges = (np.concatenate(column) for column in zip(*stick, strict=True))
    return [Band(angles, np.zeros(len(angles)), edges, PALE_STICK, f"stick, {f}"), *parts]


def _two_turns(case: Case) -> list[tuple[float, int]]:
    marks = steady_marks(case)
    return [*marks[:-1], *((time + 2 * math.pi, way) for time, way in marks)]


def figure_5(case: Case) -> Plate:
    """Extent of contact and slip above, displacement of four points beneath."""
    start = case.time("M")
    found = stretches(case, steady_marks(case))
    above = list(zone_parts(found, _angles(found, start)))
    above += _letters_over_angle(case)
    turn = np.linspace(0.0, 360.0, 721)
    solution = case.solve(time=start + np.radians(turn), x=POINTS, fields=("slip", "state"))
    moved = (solution.slip - solution.slip[0]) / (case.compliance * case.unit)
    below: list[Mark] = []
    for number, (x, look) in enumerate(zip(POINTS, _POINTS, strict=True)):
        css = look if look == "d" else f"c{look}"
        above.append(line(np.array([0.0, 360.0]), np.full(2, x), "", f"{css} dot"))
        above += named(360.0, x, f"{x:.2f}", (-14.0, 5.0), look)
        below += _displacement(turn, moved[:, number], solution.state[:, number], css)
        peak = int(np.argmin(moved[:, number]))
        below += named(float(turn[peak]), float(moved[peak, number]), f"{x:.2f}", (0.0, -10.0), look)
    panels = [
        Panel(
            "figure_05-zones",
            *axes((0.0, 360.0, _ANGLE), (0.5, 1.28, "x / a(P₀)"), _DEGREES),
            above,
            "Zones over the angle",
            760.0,
            330.0,
        ),
        _displacement_panel(below, moved),
    ]
    states = {f"state at x = {x}": [int(s) for s in solution.state[:, k]] for k, x in enumerate(POINTS)}
    return plate(
        "figure_05",
        "Figure 5. State and displacement of four points through the steady cycle, Hertz",
        "Above: contact and stick, with the letters of figure 2 and the four points x/a(P₀). Beneath: displacement of the upper "
        "face over the lower since M, A = 2/E*. Each point comes back to where it was; at 1.0 and 1.13 the way back is made while "
        "the faces are apart, so that they rub in one direction only.",
        "Two plots over the angle of the cycle: zones of stick and slip, and displacements of four points drawn by state.",
        panels,
        {"theta [degrees]": turn} | {f"s/(A P0/3) at x = {x}": moved[:, k] for k, x in enumerate(POINTS)} | states,
        keys=_STATES,
    )


def _displacement_panel(parts: list[Mark], moved: Array) -> Panel:
    low, high = float(moved.min()), float(moved.max())
    limits = (low - 0.12 * (high - low), high + 0.08 * (high - low))
    across, up = axes((0.0, 360.0, _ANGLE), (*limits, "displacement / (A P₀/3)"), _DEGREES)
    return Panel("figure_05-slip", across, up, parts, "Displacement of four points over the angle", 760.0, 360.0)


def _letters_over_angle(case: Case) -> Iterator[Mark]:
    """The letters of a steady revolution on the edge of contact."""
    start = case.time("M")
    for letter in "MFGHIKJL":
        time = case.time(letter) + (2 * math.pi if case.time(letter) < start else 0.0)
        height = float(case.width(case.events[letter].normal_load))
        shift = {"M": (8.0, 9.0), "I": (0.0, -12.0), "J": (-6.0, -12.0)}.get(letter, (0.0, 9.0))
        yield from named(math.degrees(time - start), height, letter, shift, dot=True)


def _displacement(turn: Array, moved: Array, state: NDArray[np.int8], look: str) -> Iterator[Curve]:
    """One point's displacement: slip broad under a thin line of the point's colour, separation dotted."""
    for which, broad in ((SurfaceState.SLIP_FORWARD, "forward"), (SurfaceState.SLIP_REVERSE, "reverse")):
        if (state == which).any():
            yield line(turn, np.where(_grown(state == which), moved, np.nan), "", f"{broad} broad-line")
    yield line(turn, np.where(state == SurfaceState.OPEN, np.nan, moved), "", look)
    yield line(turn, np.where(_grown(state == SurfaceState.OPEN), moved, np.nan), "", f"{look} dot")


def _grown(here: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """With one instant more at either end, so that pieces of a curve meet."""
    return np.asarray(here | np.roll(here, 1) | np.roll(here, -1))


def figure_8(case: Case) -> Plate:
    """Contact and stick of the flat and rounded contact."""
    found = stretches(case, steady_marks(case))
    angles = _angles(found, case.time("M"))
    flat = float(case.width(0.0))
    parts = [
        *zone_parts(found, angles),
        line(np.array([0.0, 360.0]), np.full(2, flat), "edge of flat, b / a(P₀)", "c1 dot"),
    ]
    across, up = axes((0.0, 360.0, _ANGLE), (0.0, 1.3, "half-width / a(P₀)"), _DEGREES)
    panel = Panel("figure_08", across, up, parts, "Half-widths over the angle", 700.0, 420.0)
    return plate(
        "figure_08",
        "Figure 8. Half-widths of contact and stick in the steady cycle, flat and rounded",
        f"b/a(P₀) = {flat:.3f}, loads as for Hertz, f = {case.friction:g}. The phases are those of figure 4b; slip stays in two "
        "bands at the edges, outside the flat face.",
        "Contact and stick half-width of the flat and rounded contact over the angle of the cycle.",
        [panel],
        _stretch_table(case, found, {"theta [degrees]": np.concatenate(angles)}),
    )
