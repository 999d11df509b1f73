"""The thirteen figures of the paper, drawn by reports/charts; their words are in paper.toml."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.charts.plate import Arrow, Axis, Band, Curve, Dot, Key, Mark, Note, Panel, Plate
from reports.charts.templating import Table
from reports.studies.paper.cases import (
    FRICTIONS,
    LETTERS,
    POINTS,
    Case,
    Paper,
    Sweep,
    sum_over_phases,
)
from reports.studies.paper.tables import WORDS, fill_in
from scenes import SurfaceState
from scenes.array_types import Array

# Looks of curves that a figure tells apart, the first to the last.
_CURVE_LOOKS = ("c0 solid", "c1 dash", "c2 dashdot", "c3 dot")
_SLIP_LOOKS = {1: ("pale-forward", "forward slip"), -1: ("pale-reverse", "reverse slip")}
_ANGLE = "angle θ of the cycle after M  [degrees]"
_DEGREES = tuple((float(angle), f"{angle}") for angle in range(0, 361, 45))
_HALF_WIDTH = Axis(0.0, 1.3, "half-width / a(P₀)")
_REVOLUTION = Axis(0.0, 360.0, _ANGLE, ticks=_DEGREES)


def all_figures(paper: Paper) -> tuple[Plate, ...]:
    """Every figure of the paper, in its order, computed again from its cases. `paper` holds the
    paper's two profiles, with their solutions.
    """
    hertz = paper.hertz_case
    rounded = paper.rounded_case
    sweep_of_hertz, sweep_of_rounded = paper.sweeps
    return (
        _figure_1(rounded),
        _figure_2(hertz),
        _figure_3(hertz),
        _figure_4a(hertz),
        _figure_4b(hertz),
        _figure_5(hertz),
        _figure_of_density("figure_06", paper, 0),
        _figure_of_sweep("figure_07a", "work", sweep_of_hertz),
        _figure_of_sweep("figure_07b", "peak", sweep_of_hertz),
        _figure_8(rounded),
        _figure_of_density("figure_09", paper, 1),
        _figure_of_sweep("figure_10a", "work", sweep_of_rounded, sweep_of_hertz),
        _figure_of_sweep("figure_10b", "peak", sweep_of_rounded, sweep_of_hertz),
    )


def _line(x: ArrayLike, y: ArrayLike, label: str = "", look: str = "solid") -> Curve:
    """A curve; NaN leaves a gap. Without a label it is not in the legend, but goes with a labelled
    one of its look.
    """
    return Curve(np.asarray(x, dtype=float), np.asarray(y, dtype=float), look, label)


def _text_at(
    x: float,
    y: float,
    text: str,
    shift: tuple[float, float] = (0.0, 0.0),
    look: str = "",
    *,
    dot: bool = False,
    css: str = "word",
) -> Iterator[Mark]:
    """What is drawn for a text beside a point of a figure, and for a dot at the point.

    Parameters
    ----------
    x, y
        coordinates of the point
    shift
        how far right of the point and above it the text stands, in about 1.3 pixels
    look
        number of its colour in the style sheet; black if empty
    dot
        whether a dot is drawn at the point
    css
        class of the text in the style sheet
    """
    if dot:
        yield Dot(x, y, f"p{look}" if look else "event", 2.8)
    if text:
        yield Note(
            x,
            y,
            text,
            f"{css} t{look}" if look else css,
            "middle",
            (1.3 * shift[0], 4.0 - 1.3 * shift[1]),
        )


def _plate(
    name: str,
    panels: Sequence[Panel],
    table: Table,
    columns: int = 1,
    keys: Iterable[Key] = (),
    **values: float,
) -> Plate:
    """A figure of the paper, with its title, caption and description from paper.toml; `values` are
    the numbers in the caption. The legend has each labelled curve and band once, and the further
    `keys`.
    """
    figure_words = next(row for row in WORDS["figure"] if row["key"] == name)
    legend: dict[str, Key] = {}
    for panel in panels:
        for mark in panel.marks:
            if isinstance(mark, Curve | Band) and mark.label:
                legend[mark.label] = Key(mark.css, mark.label, isinstance(mark, Band))
    for further_key in keys:
        legend[further_key.text] = further_key
    caption = fill_in(figure_words["text"], values)
    return Plate(
        name,
        figure_words["title"],
        caption,
        figure_words["alt"],
        tuple(panels),
        table,
        tuple(legend.values()),
        columns,
    )


def _panel(
    name: str,
    x: Axis,
    y: Axis,
    marks: Sequence[Mark],
    alt: str,
    size: tuple[float, float],
    title: str = "",
) -> Panel:
    """A panel of a figure with two axes, what is drawn in it (`marks`), a description for readers
    of screens (`alt`), and its width and height. That of figure 2 has the same scale on both axes.
    """
    width, height = size
    return Panel(name, x, y, marks, alt, width, height, title, equal=name == "figure_02")


# ------------------------------------------------------------------------------ loads and tractions
def _figure_1(case: Case) -> Plate:
    """Figure 1: the motor with an eccentric weight. The gap under its foot is the profile of the
    case, drawn much higher. `case` is the paper's ellipse of loads on one profile.
    """
    x = np.linspace(-1.9, 1.9, 191)
    height = np.asarray(case.scene.profile.height(x * case.unit_length))
    height_of_foot = height * 0.45 / height[0]
    full_angle = np.linspace(0.0, 2 * math.pi, 121)
    angle_of_arrow = np.linspace(math.radians(70), math.radians(160), 31)
    axle = (0.0, 2.35)
    radius = 0.85
    angle_of_mass = math.radians(35.0)
    direction_x = math.cos(angle_of_mass)
    direction_y = math.sin(angle_of_mass)
    place_of_weight = (axle[0] + 0.55 * direction_x, axle[1] + 0.55 * direction_y)
    tip_of_force = (axle[0] + 1.6 * direction_x, axle[1] + 1.6 * direction_y)
    heights_of_strut = [1.1, axle[1] - radius * math.sin(math.acos(0.4 / radius))]
    turn_x = axle[0] + 0.6 * np.cos(angle_of_arrow)
    turn_y = axle[1] + 0.6 * np.sin(angle_of_arrow)
    marks: list[Mark] = [
        Band(np.array([-2.6, 2.6]), np.full(2, -0.9), np.zeros(2), "body lower"),
        _line([-2.6, 2.6], [0.0, 0.0]),
        Band(x, height_of_foot, np.full(len(x), 1.1), "body upper"),
        _line(
            np.concatenate([x, x[::-1], x[:1]]),
            np.concatenate([height_of_foot, np.full(len(x), 1.1), height_of_foot[:1]]),
        ),
        Arrow((-2.5, 0.22), (-2.0, 0.22), "solid"),
        *_text_at(-2.5, 0.22, "x, Q", (14.0, 9.0)),
        Arrow((-0.505, -0.2), (0.505, -0.2), "solid"),
        Arrow((0.505, -0.2), (-0.505, -0.2), "solid"),
        *_text_at(0.0, -0.2, "flat face, 2 b", (0.0, -12.0)),
        *_text_at(1.45, 0.55, "edges of\nradius R", (0.0, 7.0)),
        *_text_at(0.0, -0.72, "half-plane"),
        _line([-0.55, -0.4], heights_of_strut),
        _line([0.55, 0.4], heights_of_strut),
        _line(
            axle[0] + radius * np.cos(full_angle),
            axle[1] + radius * np.sin(full_angle),
            look="bold",
        ),
        _line([axle[0], place_of_weight[0]], [axle[1], place_of_weight[1]], look="faint"),
        *_text_at(*axle, "", dot=True),
        _line(
            place_of_weight[0] + 0.1 * np.cos(full_angle),
            place_of_weight[1] + 0.1 * np.sin(full_angle),
            look="c1 broad-line",
        ),
        Arrow(place_of_weight, tip_of_force, "c1"),
        *_text_at(
            *tip_of_force,
            "turning force: P₁ cos ωt down,\nQ₁ cos(ωt − φ) along x",
            (72.0, 14.0),
            "1",
        ),
        _line(turn_x, turn_y, look="faint"),
        Arrow((-0.5, 2.68), (float(turn_x[-1]), float(turn_y[-1]) - 0.06), "faint"),
        *_text_at(-0.42, 2.95, "ω", (0.0, 4.0), css="tick"),
        Arrow(axle, (0.0, 1.2), "c0"),
        *_text_at(0.0, 1.3, "self-weight P₀", (-82.0, 1.0), "0"),
    ]
    panel = Panel(
        "figure_01",
        Axis(-2.8, 3.6, ""),
        Axis(-0.95, 3.6, ""),
        marks,
        "A motor on its foot",
        620.0,
        440.0,
        bare=True,
        room=(0.0, 0.0, 0.0, 0.0),
    )
    return _plate(
        "figure_01", [panel], {"x / a(P0)": x, "gap under the foot [scene units]": height}
    )


def _figure_2(case: Case) -> Plate:
    """Figure 2: the initial loading and the ellipse in the plane of P and Q, with the letters A to
    M by which the paper calls the events of contact, and the lines of gradient f and -f that define
    them. `case` is the paper's ellipse of loads on one profile.
    """
    friction = case.friction
    loads_on_limit = np.array([0.0, 4.6])
    points = {
        letter: np.array([event.normal_load, event.tangential_load, event.front_load])
        / case.unit_load
        for letter, event in case.events.items()
    }
    p_e, q_e, p_z = points["E"].tolist()
    p_g, q_g, p_t = points["G"].tolist()
    p_j, q_j, _ = points["J"].tolist()
    q_z = q_e - friction * (p_e - p_z)
    q_t = q_g + friction * (p_g - p_t)
    marks: list[Mark] = [
        _line(loads_on_limit, friction * loads_on_limit, "sliding, |Q| = f P", "faint dash fine"),
        _line(loads_on_limit, -friction * loads_on_limit, "", "faint dash fine"),
        _line(
            *case.loads(np.linspace(case.scene.load.path().start, case.time_of("A"), 101)),
            "initial loading, parabola OA",
            "c1 dashdot",
        ),
        _line([p_z, p_e], [q_z, q_e], "gradient f through E and G", "c0 solid fine"),
        _line([p_g, p_j], [q_g, q_j], "", "c0 solid fine"),
        _line([p_t, p_g], [q_t, q_g], "gradient −f through G", "c2 dot"),
        *_text_at(p_z, q_z, "Z", (-8.0, 6.0), "0", dot=True),
        *_text_at(p_t, q_t, "T", (-7.0, 7.0), "2", dot=True),
        _line(*case.loads(case.cycle_times()), "ellipse, gone round anticlockwise", "bold"),
    ]
    # Letters outside the ellipse, those of one point together.
    letters_at_point: dict[tuple[float, float], list[str]] = {}
    for letter in LETTERS:
        place_p, place_q = points[letter][:2].round(6).tolist()
        letters_at_point.setdefault((place_p, place_q), []).append(letter)
    for (place_p, place_q), letters in letters_at_point.items():
        vector_from_centre = np.array(
            [place_p - 3.0, place_q - case.load.mean_tangential_load / case.unit_load]
        )
        outward_direction = vector_from_centre / np.hypot(*vector_from_centre)
        shift = (14.0 * float(outward_direction[0]), 12.0 * float(outward_direction[1]))
        marks += _text_at(place_p, place_q, ", ".join(letters), shift, dot=True)
    marks += _text_at(0.0, 0.0, "O", (18.0, -9.0), dot=True)
    x_axis = Axis(0.0, 4.6, "normal load P / (P₀/3)")
    y_axis = Axis(-0.7, 2.8, "tangential load Q / (P₀/3)")
    panel = _panel("figure_02", x_axis, y_axis, marks, "Load path with its letters", (640.0, 480.0))
    letters_in_order = sorted(case.events, key=case.time_of)
    points_in_order = np.array([points[letter] for letter in letters_in_order])
    table: Table = {
        "letter": letters_in_order,
        "t": [case.time_of(letter) for letter in letters_in_order],
    }
    for name, column in zip(("P", "Q", "front load"), points_in_order.T, strict=True):
        table = {**table, f"{name} / (P0/3)": column.tolist()}
    return _plate("figure_02", [panel], table)


def _figure_3(case: Case) -> Plate:
    """Figure 3: pressure and shear traction at the events A to M; what slips is filled between zero
    and the limit of friction. `case` is the paper's ellipse of loads on one profile.
    """
    x = np.linspace(-1.25, 1.25, 251)
    scale = case.unit_length / case.unit_load
    times = [case.time_of(letter) for letter in LETTERS]
    solution = case.solve(time=times, x=x, fields=("pressure", "shear", "state"))
    limits_at_events = case.friction * solution.pressure * scale
    shears_at_events = solution.shear * scale
    loads_at_events = (
        np.column_stack([solution.normal_load, solution.tangential_load]) / case.unit_load
    )
    x_axis = Axis(-1.25, 1.25, "x / a(P₀)")
    y_axis = Axis(-2.4, 2.4, "traction · a(P₀) / (P₀/3)")
    panels = []
    table = {"x / a(P0)": x}
    for letter, friction_limit, shear, state, (normal_load, tangential_load) in zip(
        LETTERS, limits_at_events, shears_at_events, solution.state, loads_at_events, strict=True
    ):
        marks: list[Mark] = []
        for slip_state, sign in ((SurfaceState.SLIP_FORWARD, 1), (SurfaceState.SLIP_REVERSE, -1)):
            slips = state == slip_state
            if slips.any():
                css, label = _SLIP_LOOKS[sign]
                lower_edge = np.where(slips, 0.0, np.nan)
                upper_edge = np.where(slips, sign * friction_limit, np.nan)
                marks.append(Band(x, lower_edge, upper_edge, css, label))
        marks += [
            _line(x, friction_limit, "f p", "faint solid"),
            _line(x, -friction_limit, "−f p", "faint dash"),
        ]
        marks.append(_line(x, shear, "shear traction q", "shear-q"))
        title = f"{letter}   P = {normal_load:.2f}, Q = {tangential_load:.2f}"
        alt = f"Tractions at {letter}"
        panels.append(
            _panel(f"figure_03-{letter}", x_axis, y_axis, marks, alt, (270.0, 240.0), title)
        )
        table[f"f p at {letter}"] = friction_limit
    table |= {
        f"q at {letter}": shear for letter, shear in zip(LETTERS, shears_at_events, strict=True)
    }
    return _plate("figure_03", panels, table, columns=4)


# -------------------------------------------------------------------------------- contact and stick
@dataclass(frozen=True, eq=False)
class Zones:
    """Half-widths over a0 (n,) and the direction of slip, 0 where all sticks; turning points of
    slip stand there twice.
    """

    time: Array
    contact: Array
    stick: Array
    direction: NDArray[np.int64]

    def marks(self, x: Array) -> Iterator[Mark]:
        """Stick and slip filled over `x`, both edges drawn."""
        yield Band(x, np.zeros(len(x)), self.stick, "pale-stick", "stick")
        yield from self.slip_bands(x)
        yield _line(x, self.contact, "contact, a / a(P₀)", "bold")
        yield _line(x, self.stick, "stick, c / a(P₀)", "c2 dash")

    def slip_bands(self, x: Array, label_end: str = "") -> Iterator[Band]:
        """A band for each direction of slip, between the stick edge and the contact edge."""
        for sign, (css, label) in _SLIP_LOOKS.items():
            slips = self.direction == sign
            inner_edge = np.where(slips, self.stick, np.nan)
            outer_edge = np.where(slips, self.contact, np.nan)
            yield Band(x, inner_edge, outer_edge, css, label + label_end)

    def table(self, case: Case, first: str, x: Array) -> Table:
        """The numbers of the figure."""
        edges: Table = {
            "a / a(P0)": self.contact,
            "c / a(P0)": self.stick,
            "direction of slip": self.direction,
        }
        return {first: x, "t": self.time, "P / (P0/3)": case.loads(self.time)[0], **edges}


def _zones(case: Case, events: Sequence[tuple[float, int]], count: int = 91) -> Zones:
    """Half-widths of contact and stick through time, over a(P0), with the direction of slip.

    Parameters
    ----------
    case
        the paper's ellipse of loads on one profile
    events
        instants at which slip begins, turns or ends, each with the direction of slip from there to
        the next one: 1, -1, or 0 for stick
    count
        number of instants between two of these
    """
    time = np.concatenate(
        [np.linspace(start, end, count) for (start, _), (end, _) in pairwise(events)]
    )
    unique_times, rows_of_times = np.unique(time, return_inverse=True)
    solution = case.solve(time=unique_times)
    contact_half_width = solution.contact_half_width[rows_of_times] / case.unit_length
    stick_half_width = solution.stick_half_width[rows_of_times] / case.unit_length
    # A turning point belongs to what ends there; the second time to what starts, where all sticks.
    stick_half_width[::count] = contact_half_width[::count]
    directions = [direction for _, direction in events[:-1]]
    return Zones(time, contact_half_width, stick_half_width, np.repeat(directions, count))


def _slip_events(case: Case) -> list[tuple[float, int]]:
    """Turning points of slip of a steady revolution from M on."""
    turn = 2 * math.pi
    return [
        (case.time_of("M"), -1),
        (case.time_of("G") + turn, 0),
        (case.time_of("I") + turn, 1),
        (case.time_of("M") + turn, 0),
    ]


def _figure_4a(case: Case) -> Plate:
    """Figure 4a: half-widths of contact and stick over the sum of all changes of the normal load P,
    so that the axis resumes where P turns. `case` is the paper's ellipse of loads on one profile.
    """
    turning_events = (
        (case.time_of(letter), way_of_load)
        for letter, way_of_load in zip("BEGIM", (1, -1, 0, 1, 0), strict=True)
    )
    # P turns at C, F and K: finer than that nothing is needed, since the way of P is taken from the
    # instants.
    zones = _zones(case, [(case.scene.load.path().start, 0), *turning_events], 181)
    way_of_load = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(case.loads(zones.time)[0])))])
    way_at_letter = {
        letter: float(np.interp(case.time_of(letter), zones.time, way_of_load))
        for letter in sorted(case.events)
    }
    drawn_marks = list(zones.marks(way_of_load))
    for letter, way_there in way_at_letter.items():
        drawn_marks += _text_at(
            way_there,
            case.half_width_at(letter),
            letter,
            (0.0, 9.0),
            dot=True,
        )
    ticks = [(0.0, "0"), (1.0, "1"), (2.0, "2")]
    ticks += [
        (way_at_letter[letter], f"{case.events[letter].normal_load / case.unit_load:.3g}")
        for letter in "ACDFHKLM"
    ]
    largest_way = float(way_of_load[-1]) + 0.05
    x_axis = Axis(0.0, largest_way, "normal load P / (P₀/3), along its path", ticks=tuple(ticks))
    alt = "Half-widths over the path of P"
    panel = _panel("figure_04a", x_axis, _HALF_WIDTH, drawn_marks, alt, (820.0, 420.0))
    return _plate("figure_04a", [panel], zones.table(case, "way of P / (P0/3)", way_of_load))


def _figure_4b(case: Case) -> Plate:
    """Figure 4b: half-widths through the steady cycle for four coefficients of friction, about Q0 =
    0. `case` is the paper's ellipse of loads on one profile.
    """
    case_of = {friction: case.with_zero_mean_shear(friction) for friction in FRICTIONS}
    case_of_largest = case_of[FRICTIONS[0]]
    case_of_least = case_of[FRICTIONS[-1]]
    time_of_m = case_of_largest.time_of("M")
    # Stick and slip of the least coefficient, filled; two revolutions, for its letters are
    # elsewhere.
    events = _slip_events(case_of_least)
    second_revolution = [(time + 2 * math.pi, direction) for time, direction in events]
    zones = _zones(case_of_least, [*events[:-1], *second_revolution])
    angles = np.degrees(zones.time - time_of_m)
    is_drawn = (angles >= 0) & (angles <= 360)
    angles = angles[is_drawn]
    zones = Zones(*(getattr(zones, field.name)[is_drawn] for field in fields(zones)))
    remark = f", f = {case_of_least.friction:g}"
    filled_bands = [
        Band(angles, np.zeros(len(angles)), zones.stick, "pale-stick", f"stick{remark}"),
        *zones.slip_bands(angles, remark),
    ]
    # Just after M, for f = 1 the instant of M itself still belongs to forward slip.
    angles_of_curves = np.linspace(1e-6, 360.0, 721)
    stick_by_friction = {
        friction: case_of_f.solve(time=time_of_m + np.radians(angles_of_curves)).stick_half_width
        / case_of_f.unit_length
        for friction, case_of_f in case_of.items()
    }
    curves = [
        _line(angles_of_curves, stick_half_width, f"c / a(P₀), f = {friction}", look)
        for (friction, stick_half_width), look in zip(
            stick_by_friction.items(), _CURVE_LOOKS, strict=True
        )
    ]
    contact_half_width = case.scaled_half_width(
        case_of_largest.solve(time=time_of_m + np.radians(angles_of_curves)).normal_load
    )
    curves.append(_line(angles_of_curves, contact_half_width, "contact, a / a(P₀)", "bold"))
    axis_in_words = "angle θ of the cycle after M for f = 1  [degrees]"
    x_axis = Axis(0.0, 360.0, axis_in_words, ticks=_DEGREES)
    alt = "Half-widths over the angle"
    panel = _panel("figure_04b", x_axis, _HALF_WIDTH, [*filled_bands, *curves], alt, (700.0, 430.0))
    table = {"theta [degrees]": angles_of_curves, "a / a(P0)": contact_half_width} | {
        f"c / a(P0), f = {friction}": stick_half_width
        for friction, stick_half_width in stick_by_friction.items()
    }
    return _plate("figure_04b", [panel], table)


def _figure_5(case: Case) -> Plate:
    """Figure 5, in two panels over the angle of the steady cycle. Above: the half-widths of contact
    and stick, and the places of four points. Below: the displacement of the four points, broad
    where they slip and dotted where they are out of contact. `case` is the paper's ellipse of loads
    on one profile.
    """
    time_of_m = case.time_of("M")
    zones = _zones(case, _slip_events(case))
    marks_above = list(zones.marks(np.degrees(zones.time - time_of_m)))
    for letter in "MFGHIKJL":
        time = case.time_of(letter) + (2 * math.pi if case.time_of(letter) < time_of_m else 0.0)
        offset_of_letter = {"M": (8.0, 9.0), "I": (0.0, -12.0), "J": (-6.0, -12.0)}.get(
            letter, (0.0, 9.0)
        )
        height = case.half_width_at(letter)
        marks_above += _text_at(
            math.degrees(time - time_of_m), height, letter, offset_of_letter, dot=True
        )
    angles = np.linspace(0.0, 360.0, 721)
    marks_below: list[Mark] = []
    solution = case.solve(time=time_of_m + np.radians(angles), x=POINTS, fields=("slip", "state"))
    displacement = (solution.slip - solution.slip[0]) / (case.unit_slip)
    for x, colour, displacement_of_point, state in zip(
        POINTS, "d435", displacement.T, solution.state.T, strict=True
    ):
        css = colour if colour == "d" else f"c{colour}"
        marks_above.append(_line([0.0, 360.0], [x, x], "", f"{css} dot"))
        marks_above += _text_at(360.0, x, f"{x:.2f}", (-14.0, 5.0), colour)
        marks_below += _displacement_line(angles, displacement_of_point, state, css)
        index_of_least = int(np.argmin(displacement_of_point))
        place_of_least = (
            float(angles[index_of_least]),
            float(displacement_of_point[index_of_least]),
        )
        marks_below += _text_at(*place_of_least, f"{x:.2f}", (0.0, -10.0), colour)
    least_displacement = float(displacement.min())
    largest_displacement = float(displacement.max())
    range_shown = largest_displacement - least_displacement
    y_axis = Axis(
        least_displacement - 0.12 * range_shown,
        largest_displacement + 0.08 * range_shown,
        "displacement / (A P₀/3)",
    )
    extent_axis = Axis(0.5, 1.28, "x / a(P₀)")
    alt_of_zones = "Zones over the angle"
    alt_of_slip = "Displacement of four points over the angle"
    panels = [
        _panel(
            "figure_05-zones", _REVOLUTION, extent_axis, marks_above, alt_of_zones, (760.0, 330.0)
        ),
        _panel("figure_05-slip", _REVOLUTION, y_axis, marks_below, alt_of_slip, (760.0, 360.0)),
    ]
    looks = {
        "faint solid": "sticking",
        "forward broad-line": "slipping forward",
        "reverse broad-line": "slipping in reverse",
    }
    keys = [Key(css, text) for css, text in (looks | {"faint dot": "separated"}).items()]
    table: dict[str, Any] = {"theta [degrees]": angles}
    for x, displacement_of_point in zip(POINTS, displacement.T, strict=True):
        table[f"s/(A P0/3) at x = {x}"] = displacement_of_point
    for x, state in zip(POINTS, solution.state.T, strict=True):
        table[f"state at x = {x}"] = list(map(int, state))
    return _plate("figure_05", panels, table, keys=keys)


def _with_neighbours(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask with one instant more at either end of each run, so that pieces of a curve meet."""
    return np.asarray(mask | np.roll(mask, 1) | np.roll(mask, -1))


def _displacement_line(
    angles: Array, displacement: Array, state: NDArray[np.int8], css: str
) -> Iterator[Mark]:
    """The displacement of a point through the cycle as lines over the angle, (n,) each: broad where
    it slips, dotted where it is out of contact. `state` is its state at each angle, `css` its look.
    """
    for slip_state, direction in (
        (SurfaceState.SLIP_FORWARD, "forward"),
        (SurfaceState.SLIP_REVERSE, "reverse"),
    ):
        slips = state == slip_state
        if slips.any():
            slipping_y = np.where(_with_neighbours(slips), displacement, np.nan)
            yield _line(angles, slipping_y, "", f"{direction} broad-line")
    is_open = state == SurfaceState.OPEN
    yield _line(angles, np.where(is_open, np.nan, displacement), "", css)
    yield _line(angles, np.where(_with_neighbours(is_open), displacement, np.nan), "", f"{css} dot")


def _figure_8(case: Case) -> Plate:
    """Figure 8: half-widths of contact and stick of the flat and rounded contact through the cycle.
    `case` is the paper's ellipse of loads on one profile.
    """
    zones = _zones(case, _slip_events(case))
    edge_of_flat = float(case.scaled_half_width(0.0))
    angle = np.degrees(zones.time - case.time_of("M"))
    marks = [
        *zones.marks(angle),
        _line([0.0, 360.0], [edge_of_flat, edge_of_flat], "edge of flat, b / a(P₀)", "c1 dot"),
    ]
    alt = "Half-widths over the angle"
    panel = _panel("figure_08", _REVOLUTION, _HALF_WIDTH, marks, alt, (700.0, 420.0))
    return _plate(
        "figure_08",
        [panel],
        zones.table(case, "theta [degrees]", angle),
        flat=edge_of_flat,
        friction=case.friction,
    )


# --------------------------------------------------------------------------------------------- work
def _figure_of_density(name: str, paper: Paper, index_of_case: int) -> Plate:
    """Figures 6 and 9: dissipation W(x) with the parts of the phases; `index_of_case` 0 for Hertz,
    1 for the flat and rounded contact. `paper` holds the paper's two profiles, with their
    solutions.
    """
    case = (paper.hertz_case, paper.rounded_case)[index_of_case]
    peak = paper.peaks[index_of_case]
    inner_edge = case.stick_edge
    outer_edge = case.outer_edge
    share_of_way = float(peak.fraction)
    places_in_zone = (
        inner_edge + (outer_edge - inner_edge) * (1 - np.cos(np.linspace(0, np.pi, 241))) / 2
    )
    x = np.concatenate([[0.95 * inner_edge], places_in_zone, [outer_edge + 0.05 * inner_edge]])
    phases = case.density_of_phases(x)
    density = sum_over_phases(phases)
    peak_place = float(peak.place) / case.unit_length
    peak_value = float(peak.value) * case.unit_length / case.unit_work
    marks: list[Mark] = [
        _line(x, density, "whole cycle", "bold"),
        _line(x, phases["IJ"], "forward, I–J", "c1 dash"),
        _line(x, phases["JM"], "forward, J–M", "c4 dashdot"),
        _line(x, phases["EG"], "reverse, E–G", "c0 dot"),
        *(
            _line([edge, edge], [0.0, 1.12 * peak_value], "", "faint dot fine")
            for edge in (inner_edge, outer_edge)
        ),
        *_text_at(
            inner_edge, 1.12 * peak_value, f"stick edge {inner_edge:.3f}", (42.0, 6.0), css="tick"
        ),
        *_text_at(
            outer_edge,
            1.12 * peak_value,
            f"edge of contact {outer_edge:.3f}",
            (-50.0, 6.0),
            css="tick",
        ),
        *_text_at(peak_place, peak_value, f"{share_of_way:.1%} of the way", (0.0, 10.0), dot=True),
    ]
    x_axis = Axis(0.95 * inner_edge, outer_edge + 0.05 * inner_edge, "x / a(P₀)")
    y_axis = Axis(0.0, 1.22 * peak_value, "W(x) · a(P₀) / (A f² P₀²)")
    panel = _panel(name, x_axis, y_axis, marks, "Pointwise dissipation over x", (640.0, 400.0))
    table = {"x / a(P0)": x, "W a(P0)/(A f^2 P0^2)": density}
    table |= {f"in {phase}": phases[phase] for phase in ("IJ", "JM", "EG")}
    return _plate(name, [panel], table, fraction=share_of_way, place=peak_place)


def _figure_of_sweep(
    name: str, quantity: str, sweep: Sweep, pale_sweep: Sweep | None = None
) -> Plate:
    """Figures 7 and 10: the dissipation ("work") or its peak ("peak") over P0/P1, a curve for each
    coefficient of friction f of `sweep`; those of `pale_sweep`, if given, as pale lines beneath.
    """
    label = {"work": "W / (A P₁²)", "peak": "max W(x) · a(P₀) / (A P₁²)"}[quantity]
    values = getattr(sweep, quantity)
    largest_value = float(values.max())
    marks: list[Mark] = []
    if pale_sweep is not None:
        pale_values = getattr(pale_sweep, quantity)
        largest_value = max(largest_value, float(pale_values.max()))
        for number, (load_ratios, values_at_friction) in enumerate(
            zip(pale_sweep.load_ratio, pale_values, strict=True)
        ):
            marks.append(
                _line(
                    load_ratios,
                    values_at_friction,
                    "" if number else "Hertz, same f",
                    "faint solid fine",
                )
            )
    for number, (friction, load_ratios, values_at_friction) in enumerate(
        zip(sweep.frictions, sweep.load_ratio, values, strict=True)
    ):
        marks.append(
            _line(load_ratios, values_at_friction, f"f = {friction:g}", _CURVE_LOOKS[number])
        )
        marks += _text_at(
            float(load_ratios[0]), float(values_at_friction[0]), "", look=f"{number}", dot=True
        )
    x_axis = Axis(1.0, float(sweep.load_ratio.max()), "P₀ / P₁")
    y_axis = Axis(0.0, 1.08 * largest_value, label)
    panel = _panel(name, x_axis, y_axis, marks, f"{label} over P₀/P₁", (620.0, 400.0))
    table = {
        f"P0/P1, f = {friction:g}": load_ratios
        for friction, load_ratios in zip(sweep.frictions, sweep.load_ratio, strict=True)
    }
    for friction, values_at_friction in zip(sweep.frictions, values, strict=True):
        table[f"{quantity}, f = {friction:g}"] = values_at_friction
    return _plate(name, [panel], table)
