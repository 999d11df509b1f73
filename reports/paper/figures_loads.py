"""Figures 1 to 3 of the paper: the motor on its foot, the load history, the tractions at the points A to M."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Arrow, Band, Curve, Mark
from reports.charts.plate import Panel, Plate
from reports.paper.cases import LETTERS, Case
from reports.paper.plots import axes, line, named, plate
from scenes import SurfaceState, load_scene

Array = NDArray[np.float64]

PALE_FORWARD, PALE_REVERSE, PALE_STICK = "pale-forward", "pale-reverse", "pale-stick"
LOAD = "/ (P₀/3)"


def figure_1(case: Case) -> Plate:
    """The motor with an eccentric weight; the gap under its foot is the profile of the case, drawn much higher."""
    scene = load_scene("motor")
    x = np.linspace(-1.9, 1.9, 191)
    height = np.asarray(case.scene.profile.height(x * case.length))
    foot = height * 0.45 / height[0]
    parts = [*_foot(x, foot), *_motor()]
    across, up = axes((-2.8, 3.6, ""), (-0.95, 3.6, ""))
    panel = Panel("figure_01", across, up, parts, "A motor on its foot", 620.0, 440.0, bare=True, room=(0.0, 0.0, 0.0, 0.0))
    return plate(
        "figure_01",
        "Figure 1. A motor with an eccentric mass on its foot",
        "The foot is flat with rounded edges; its gap is that of the library's profile, drawn much higher than it is. The weight "
        "presses, the turning mass adds a force that varies in P and Q a quarter of a revolution apart (library scene "
        f"{scene.name}).",
        "A motor on a foot with rounded edges on a half-plane, its weight and the turning force of an eccentric mass as arrows.",
        [panel],
        {"x / a(P0)": x, "gap under the foot [scene units]": height},
    )


def _foot(x: Array, foot: Array) -> list[Mark]:
    """The half-plane and the foot on it."""
    return [
        Band(np.array([-2.6, 2.6]), np.full(2, -0.9), np.zeros(2), "body lower"),
        line(np.array([-2.6, 2.6]), np.zeros(2)),
        Band(x, foot, np.full(len(x), 1.1), "body upper"),
        line(np.concatenate([x, x[::-1], x[:1]]), np.concatenate([foot, np.full(len(x), 1.1), foot[:1]])),
        Arrow((-2.5, 0.22), (-2.0, 0.22), "solid"),
        *named(-2.5, 0.22, "x, Q", (14.0, 9.0)),
        Arrow((-0.505, -0.2), (0.505, -0.2), "solid"),
        Arrow((0.505, -0.2), (-0.505, -0.2), "solid"),
        *named(0.0, -0.2, "flat face, 2 b", (0.0, -12.0)),
        *named(1.45, 0.55, "edges of\nradius R", (0.0, 7.0)),
        *named(0.0, -0.72, "half-plane"),
    ]


def _motor() -> list[Mark]:
    """The motor on its struts, its weight and its turning mass."""
    circle = np.linspace(0.0, 2 * math.pi, 121)
    axle, radius, mass = (0.0, 2.35), 0.85, math.radians(35.0)
    weight = (axle[0] + 0.55 * math.cos(mass), axle[1] + 0.55 * math.sin(mass))
    tip = (axle[0] + 1.6 * math.cos(mass), axle[1] + 1.6 * math.sin(mass))
    turn = np.linspace(math.radians(70), math.radians(160), 31)
    return [
        line(np.array([-0.55, -0.4]), np.array([1.1, axle[1] - radius * math.sin(math.acos(0.4 / radius))])),
        line(np.array([0.55, 0.4]), np.array([1.1, axle[1] - radius * math.sin(math.acos(0.4 / radius))])),
        line(axle[0] + radius * np.cos(circle), axle[1] + radius * np.sin(circle), look="bold"),
        line(np.array([axle[0], weight[0]]), np.array([axle[1], weight[1]]), look="faint"),
        *named(*axle, "", dot=True),
        line(weight[0] + 0.1 * np.cos(circle), weight[1] + 0.1 * np.sin(circle), look="c1 broad-line"),
        Arrow(weight, tip, "c1"),
        *named(*tip, "turning force: P₁ cos ωt down,\nQ₁ cos(ωt − φ) along x", (72.0, 14.0), "1"),
        line(axle[0] + 0.6 * np.cos(turn), axle[1] + 0.6 * np.sin(turn), look="faint"),
        Arrow((-0.5, 2.68), (axle[0] + 0.6 * math.cos(turn[-1]), axle[1] + 0.6 * math.sin(turn[-1]) - 0.06), "faint"),
        *named(-0.42, 2.95, "ω", (0.0, 4.0), css="tick"),
        Arrow(axle, (0.0, 1.2), "c0"),
        *named(0.0, 1.3, "self-weight P₀", (-82.0, 1.0), "0"),
    ]


def figure_2(case: Case) -> Plate:
    """The initial loading and the ellipse in the plane of the loads, with the letters and the lines that define them."""
    start = case.scene.load.path().start
    way, turn = np.linspace(start, case.time("A"), 101), case.round_times()
    (p_way, q_way), (p, q) = case.loads(way), case.loads(turn)
    cone = np.array([0.0, 4.6])
    parts: list[Mark] = [
        line(cone, case.friction * cone, "sliding, |Q| = f P", "faint dash fine"),
        line(cone, -case.friction * cone, "", "faint dash fine"),
        line(p_way, q_way, "initial loading, parabola OA", "c1 dashdot"),
        *_constructions(case),
        line(p, q, "ellipse, gone round anticlockwise", "bold"),
        *_letters(case),
        *named(0.0, 0.0, "O", (18.0, -9.0), dot=True),
    ]
    label = f"load P {LOAD}"
    across, up = axes((0.0, 4.6, f"normal {label}"), (-0.7, 2.8, f"tangential load Q {LOAD}"))
    panel = Panel("figure_02", across, up, parts, "Load path with its letters", 640.0, 480.0, equal=True)
    letters = sorted(case.events, key=case.time)
    return plate(
        "figure_02",
        "Figure 2. The path of the loads",
        "Letters that share a point (A and H, B and I, C and K, D and L, E and M) are a revolution apart. dQ/dP = f at B, I, E "
        "and M, −f at G. The line of gradient f through E meets initial loading at Z, the one through G the ellipse at J, the line "
        "of gradient −f through G meets the first at T: a(P_Z) and a(P_T) bound stick in the first cycle and for good. In this "
        "example K comes before J.",
        "A circle in the P-Q plane with the parabola from the origin and the letters A to M.",
        [panel],
        {
            "letter": letters,
            "t": [case.time(letter) for letter in letters],
            "P / (P0/3)": [case.events[letter].normal_load / case.unit for letter in letters],
            "Q / (P0/3)": [case.events[letter].tangential_load / case.unit for letter in letters],
            "front load / (P0/3)": [case.events[letter].front_load / case.unit for letter in letters],
        },
    )


def _constructions(case: Case) -> Iterator[Mark]:
    """Lines of gradient +-f through E and G."""
    f = case.friction
    p_e, q_e, p_z = _point(case, "E")
    p_g, q_g, p_t = _point(case, "G")
    p_j, q_j, _ = _point(case, "J")
    q_z, q_t = q_e - f * (p_e - p_z), q_g + f * (p_g - p_t)
    yield line(np.array([p_z, p_e]), np.array([q_z, q_e]), "gradient f through E and G", "c0 solid fine")
    yield line(np.array([p_g, p_j]), np.array([q_g, q_j]), "", "c0 solid fine")
    yield line(np.array([p_t, p_g]), np.array([q_t, q_g]), "gradient −f through G", "c2 dot")
    yield from named(p_z, q_z, "Z", (-8.0, 6.0), "0", dot=True)
    yield from named(p_t, q_t, "T", (-7.0, 7.0), "2", dot=True)


def _point(case: Case, letter: str) -> tuple[float, float, float]:
    """P, Q and the load at the front of slip, scaled."""
    event = case.events[letter]
    return event.normal_load / case.unit, event.tangential_load / case.unit, event.front_load / case.unit


def _letters(case: Case) -> Iterator[Mark]:
    """Letters outside the ellipse, those of one point together."""
    groups: dict[tuple[float, float], str] = {}
    for letter in LETTERS:
        p, q, _ = _point(case, letter)
        place = (round(p, 6), round(q, 6))
        groups[place] = f"{groups[place]}, {letter}" if place in groups else letter
    centre = (3.0, case.load.mean_tangential_load / case.unit)
    for (p, q), text in groups.items():
        away = np.array([p - centre[0], q - centre[1]])
        away = away / np.hypot(*away)
        yield from named(p, q, text, (14.0 * float(away[0]), 12.0 * float(away[1])), dot=True)


def figure_3(case: Case) -> Plate:
    """Pressure and shear traction at A to M."""
    x = np.linspace(-1.25, 1.25, 251)
    times = [case.time(letter) for letter in LETTERS]
    solution = case.solve(time=times, x=x, fields=("pressure", "shear", "state"))
    scale = case.length / case.unit
    limit, shear = case.friction * solution.pressure * scale, solution.shear * scale
    panels = []
    for number, letter in enumerate(LETTERS):
        loads = f"P = {solution.normal_load[number] / case.unit:.2f}, Q = {solution.tangential_load[number] / case.unit:.2f}"
        panels.append(
            Panel(
                f"figure_03-{letter}",
                *axes((-1.25, 1.25, "x / a(P₀)"), (-2.4, 2.4, "traction · a(P₀) / (P₀/3)")),
                [*_slip_bands(x, solution.state[number], limit[number]), *_tractions(x, limit[number], shear[number])],
                f"Tractions at {letter}",
                270.0,
                240.0,
                f"{letter}   {loads}",
            )
        )
    return plate(
        "figure_03",
        "Figure 3. Tractions of the Hertzian contact at the points A to M",
        "Loads are over P₀/3. A to D belong to the first cycle, E to M to the steady state; the instants are those of figure 2, "
        "where slip ends the last one of slip. In slip q meets f p (forward) or −f p (reverse); from G on the tractions inside "
        "keep the hooks of the slip before.",
        "Thirteen small plots of pressure times friction and shear traction over the contact.",
        panels,
        {"x / a(P0)": x}
        | {f"f p at {letter}": limit[number] for number, letter in enumerate(LETTERS)}
        | {f"q at {letter}": shear[number] for number, letter in enumerate(LETTERS)},
        columns=4,
    )


def _tractions(x: Array, limit: Array, shear: Array) -> list[Curve]:
    """Shear traction between the limits of friction."""
    return [
        line(x, limit, "f p", "faint solid"),
        line(x, -limit, "−f p", "faint dash"),
        line(x, shear, "shear traction q", "shear-q"),
    ]


def _slip_bands(x: Array, state: NDArray[np.int8], limit: Array) -> Iterator[Band]:
    """What slips, filled between zero and the limit of friction."""
    for which, colour, label, sign in (
        (SurfaceState.SLIP_FORWARD, PALE_FORWARD, "forward slip", 1),
        (SurfaceState.SLIP_REVERSE, PALE_REVERSE, "reverse slip", -1),
    ):
        here = state == which
        if here.any():
            top = np.where(here, sign * limit, np.nan)
            yield Band(x, np.where(here, 0.0, np.nan), top, colour, label)
