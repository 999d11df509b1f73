"""The thirteen figures of the paper, drawn by reports/charts; their words are in paper.toml."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
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
from reports.studies.paper.tables import PAPER_WORDS, fill_in
from scenes import SurfaceState
from scenes.array_types import Array
from semi_analytic import PeakBatch

# Looks of the curves of a figure in the style sheet, the first to the last.
_CURVE_LOOKS = ("c0 solid", "c1 dash", "c2 dashdot", "c3 dot")
# Direction of slip -> look of its band and label.
_SLIP_LOOKS = {1: ("pale-forward", "forward slip"), -1: ("pale-reverse", "reverse slip")}
# Colours of the four points of figure 5 in the style sheet.
_POINT_COLOURS = "d435"
_ANGLE = "angle θ of the cycle after M  [degrees]"
# Ticks of an axis of angles, each with its text.
_DEGREES = tuple((float(angle), f"{angle}") for angle in range(0, 361, 45))
# Axes that several figures share: half-widths, and the angle of a revolution.
_HALF_WIDTH = Axis(0.0, 1.3, "half-width / a(P₀)")
_REVOLUTION = Axis(0.0, 360.0, _ANGLE, ticks=_DEGREES)


def all_figures(paper: Paper) -> tuple[Plate, ...]:
    """Every figure of the paper, in its order, computed again.

    `paper` holds for each of both profiles the case, which is the paper's ellipse of loads on that
    profile. It also holds place and value of the peak of W(x), the dissipation per area, and a
    sweep of the dissipation and this peak over mean load and friction.
    """
    hertz_case = paper.hertz_case
    rounded_case = paper.rounded_case
    hertz_peak, rounded_peak = paper.peaks
    hertz_sweep, rounded_sweep = paper.sweeps
    return (
        _figure_1(rounded_case),
        _figure_2(hertz_case),
        _figure_3(hertz_case),
        _figure_4a(hertz_case),
        _figure_4b(hertz_case),
        _figure_5(hertz_case),
        _figure_of_density("figure_06", hertz_case, hertz_peak),
        _figure_of_sweep("figure_07a", "work", hertz_sweep),
        _figure_of_sweep("figure_07b", "peak", hertz_sweep),
        _figure_8(rounded_case),
        _figure_of_density("figure_09", rounded_case, rounded_peak),
        _figure_of_sweep("figure_10a", "work", rounded_sweep, hertz_sweep),
        _figure_of_sweep("figure_10b", "peak", rounded_sweep, hertz_sweep),
    )


def _line(x: ArrayLike, y: ArrayLike, label: str = "", look: str = "solid") -> Curve:
    """A curve through points (n,); NaN leaves a gap. `look` is its class in the style sheet.
    Without a label it is not in the legend, but goes with a labelled one of its look.
    """
    return Curve(np.asarray(x, dtype=float), np.asarray(y, dtype=float), look, label)


def _text_at(
    x: float,
    y: float,
    text: str,
    shift: tuple[float, float] = (0.0, 0.0),
    colour: str = "",
    *,
    dot: bool = False,
    text_class: str = "word",
) -> Iterator[Mark]:
    """The marks of a text beside a point of a figure, and of a dot at the point.

    Parameters
    ----------
    x, y
        coordinates of the point, in the numbers of the axes
    text
        nothing is written if it is empty
    shift
        how far right of the point and above it the text stands, in units of 1.3 pixels
    colour
        number or letter of the colour in the style sheet; black if empty
    dot
        whether a dot is drawn at the point
    text_class
        class of the text in the style sheet
    """
    if dot:
        yield Dot(x, y, f"p{colour}" if colour else "event", 2.8)
    if text:
        # Note: x, y, text, look, anchor, shift
        yield Note(
            x,
            y,
            text,
            f"{text_class} t{colour}" if colour else text_class,
            "middle",
            # SVG counts downwards; 4 pixels are half the height of a letter
            (1.3 * shift[0], 4.0 - 1.3 * shift[1]),
        )


def _plate(
    name: str,
    panels: Sequence[Panel],
    table: Table,
    n_columns: int = 1,
    keys: Iterable[Key] = (),
    **numbers: float,
) -> Plate:
    """A figure of the paper, with its title, caption and description (for readers who can't see it)
    from paper.toml. Its legend has each labelled curve and band once, and the further `keys`, which
    are entries of the legend.

    `name` is that of the figure and of its files. `numbers` are filled into the caption. `table`
    has the columns of its CSV file. Of the panels `n_columns` stand side by side.
    """
    # texts of the figure in paper.toml, by their names
    # PAPER_WORDS: the content of paper.toml
    figure_words = next(row for row in PAPER_WORDS["figure"] if row["key"] == name)

    # text of an entry -> entry, with the look of its mark: a line, or a patch for a band
    legend: dict[str, Key] = {}
    for panel in panels:
        for mark in panel.marks:
            if isinstance(mark, Curve | Band) and mark.label:
                legend[mark.label] = Key(mark.css, mark.label, isinstance(mark, Band))
    for further_key in keys:
        legend[further_key.text] = further_key
    caption = fill_in(figure_words["text"], numbers)
    # Plate: name, title, caption, description, panels, CSV table, legend, panels in a row
    return Plate(
        name,
        figure_words["title"],
        caption,
        figure_words["alt"],
        tuple(panels),
        table,
        tuple(legend.values()),
        n_columns,
    )


def _panel(
    name: str,
    x_axis: Axis,
    y_axis: Axis,
    marks: Sequence[Mark],
    alt: str,
    size: tuple[float, float],
    title: str = "",
) -> Panel:
    """A panel of a figure with two axes, what is drawn in it (`marks`), a description for readers
    who can't see it (`alt`), and its width and height in pixels (`size`). The panel of figure 2 has
    the same scale on both axes.
    """
    width, height = size
    has_equal_scales = name == "figure_02"
    return Panel(
        name, x_axis, y_axis, marks, alt, width, height, title, has_equal_scales=has_equal_scales
    )


# ------------------------------------------------------------------------------ loads and tractions
def _figure_1(case: Case) -> Plate:
    """Figure 1: the motor with an eccentric weight, which turns about an axle. The gap under its
    foot is the profile of the case, drawn much higher.

    `case` is the paper's ellipse of loads on one profile. Lengths are those of the drawing, in
    which a horizontal unit is a0, the contact half-width at the mean load (`unit_length`).
    """
    # the gap at x/a0, in the scene's unit of length; it is drawn 0.45 high at the ends of the foot
    x = np.linspace(-1.9, 1.9, 191)
    initial_gap = np.asarray(case.scene.profile.height(x * case.unit_length))
    underside_of_foot = initial_gap * 0.45 / initial_gap[0]
    panel = Panel(
        "figure_01",
        Axis(-2.8, 3.6, ""),
        Axis(-0.95, 3.6, ""),
        [*_marks_of_foot(x, underside_of_foot), *_marks_of_rotor()],
        "A motor on its foot",
        620.0,
        440.0,
        without_axes=True,
        room=(0.0, 0.0, 0.0, 0.0),
    )
    table = {"x / a(P0)": x, "gap under the foot [scene units]": initial_gap}
    return _plate("figure_01", [panel], table)


def _marks_of_foot(x: Array, underside_of_foot: Array) -> Iterator[Mark]:
    """The marks of a motor's foot on a half-plane, with names of their parts: both bodies, the
    direction of x and Q, the width of the flat face. `underside_of_foot` (n,) is the height of its
    lower face over the half-plane at `x` (n,), in units of the drawing; its top is 1.1 high.
    """
    # _line(x, y), _text_at(x, y, text, shift to the right and upwards)
    yield Band(np.array([-2.6, 2.6]), np.full(2, -0.9), np.zeros(2), "body lower")
    yield _line([-2.6, 2.6], [0.0, 0.0])
    yield Band(x, underside_of_foot, np.full(len(x), 1.1), "body upper")
    outline_x = np.concatenate([x, x[::-1], x[:1]])
    outline_y = np.concatenate([underside_of_foot, np.full(len(x), 1.1), underside_of_foot[:1]])
    yield _line(outline_x, outline_y)
    yield Arrow((-2.5, 0.22), (-2.0, 0.22), "solid")
    yield from _text_at(-2.5, 0.22, "x, Q", (14.0, 9.0))
    yield Arrow((-0.505, -0.2), (0.505, -0.2), "solid")
    yield Arrow((0.505, -0.2), (-0.505, -0.2), "solid")
    yield from _text_at(0.0, -0.2, "flat face, 2 b", (0.0, -12.0))
    yield from _text_at(1.45, 0.55, "edges of\nradius R", (0.0, 7.0))
    yield from _text_at(0.0, -0.72, "half-plane")


def _marks_of_rotor() -> Iterator[Mark]:
    """The marks of a motor above its foot, with names of the forces: two struts; the rotor on its
    axle; its eccentric weight with the force that turns with it; the sense of rotation; and the
    self-weight. Lengths are those of the drawing.
    """
    circle_angles = np.linspace(0.0, 2 * math.pi, 121)
    circle_x = np.cos(circle_angles)
    circle_y = np.sin(circle_angles)
    axle = (0.0, 2.35)
    rotor_radius = 0.85
    # the struts end at the rotor
    strut_heights = [1.1, axle[1] - rotor_radius * math.sin(math.acos(0.4 / rotor_radius))]
    yield _line([-0.55, -0.4], strut_heights)
    yield _line([0.55, 0.4], strut_heights)
    yield _line(axle[0] + rotor_radius * circle_x, axle[1] + rotor_radius * circle_y, look="bold")

    # the eccentric weight, and the force in its direction from the axle
    weight_angle = math.radians(35.0)
    direction_x = math.cos(weight_angle)
    direction_y = math.sin(weight_angle)
    place_of_weight = (axle[0] + 0.55 * direction_x, axle[1] + 0.55 * direction_y)
    force_tip = (axle[0] + 1.6 * direction_x, axle[1] + 1.6 * direction_y)
    yield _line([axle[0], place_of_weight[0]], [axle[1], place_of_weight[1]], look="faint")
    yield from _text_at(*axle, "", dot=True)
    weight_x = place_of_weight[0] + 0.1 * circle_x
    weight_y = place_of_weight[1] + 0.1 * circle_y
    yield _line(weight_x, weight_y, look="c1 broad-line")
    yield Arrow(place_of_weight, force_tip, "c1")
    words_of_force = "turning force: P₁ cos ωt down,\nQ₁ cos(ωt − φ) along x"
    yield from _text_at(*force_tip, words_of_force, (72.0, 14.0), "1")

    # the sense of rotation: an arc with the head of an arrow
    arc_angles = np.linspace(math.radians(70), math.radians(160), 31)
    arc_x = axle[0] + 0.6 * np.cos(arc_angles)
    arc_y = axle[1] + 0.6 * np.sin(arc_angles)
    yield _line(arc_x, arc_y, look="faint")
    yield Arrow((-0.5, 2.68), (float(arc_x[-1]), float(arc_y[-1]) - 0.06), "faint")
    yield from _text_at(-0.42, 2.95, "ω", (0.0, 4.0), text_class="tick")
    yield Arrow(axle, (0.0, 1.2), "c0")
    yield from _text_at(0.0, 1.3, "self-weight P₀", (-82.0, 1.0), "0")


def _figure_2(case: Case) -> Plate:
    """Figure 2: the initial loading and the ellipse of the cycle in the plane of P and Q. Events,
    such as the end of forward slip (E), have the letters A to M. Lines of gradient f and -f through
    E and G lead to the load at the stick edge there.

    `case` is the paper's ellipse of loads on one profile; f is its `friction`. Loads are drawn over
    P0/3, a third of the mean normal load (`unit_load`).

    # notation: f coefficient of friction, P normal load, P0 its mean, Q tangential load
    """
    # letter -> P, Q and the load at the stick edge (3,), over P0/3; `front_load`: the normal load
    # under which the contact would be as wide as the stick zone is at the event
    loads_by_letter = {
        letter: np.array([event.normal_load, event.tangential_load, event.front_load])
        / case.unit_load
        for letter, event in case.events.items()
    }
    # _line(P, Q, label, look), _text_at(P, Q, text, shift)
    p_on_limit = np.array([0.0, 4.6])  # at both ends of the drawn limit of gross sliding
    q_on_limit = case.friction * p_on_limit
    initial_times = np.linspace(case.scene.load.path().start, case.time_of("A"), 101)
    marks: list[Mark] = [
        _line(p_on_limit, q_on_limit, "sliding, |Q| = f P", "faint dash fine"),
        _line(p_on_limit, -q_on_limit, "", "faint dash fine"),
        _line(*case.scaled_loads(initial_times), "initial loading, parabola OA", "c1 dashdot"),
        *_lines_of_gradient_f(case.friction, loads_by_letter),
        _line(*case.scaled_loads(case.cycle_times()), "ellipse, gone round anticlockwise", "bold"),
        *_letters_around_ellipse(case, loads_by_letter),
        *_text_at(0.0, 0.0, "O", (18.0, -9.0), dot=True),
    ]
    x_axis = Axis(0.0, 4.6, "normal load P / (P₀/3)")
    y_axis = Axis(-0.7, 2.8, "tangential load Q / (P₀/3)")
    panel = _panel("figure_02", x_axis, y_axis, marks, "Load path with its letters", (640.0, 480.0))
    return _plate("figure_02", [panel], _table_of_events(case, loads_by_letter))


def _lines_of_gradient_f(
    friction_coefficient: float, loads_by_letter: Mapping[str, Array]
) -> Iterator[Mark]:
    """The lines of gradient f and -f in the plane of P and Q that define the events of figure 2,
    with the letters Z and T at their ends.

    The line of gradient f through E (end of forward slip) ends at Z, on the initial loading. The
    line of gradient -f through G (end of reverse slip) ends at T, at the load of the permanent
    stick edge; the line of gradient f from G ends at J. J is the event of forward slip at which the
    stick edge is where the contact edge was at G.

    `loads_by_letter` is letter -> P, Q and the load at the stick edge (3,), over P0/3.

    # notation: f friction coefficient, P normal load, P0 its mean, Q tangential load
    """
    # loads at E, G and J; Z and T have the loads at the stick edge at E and G
    p_e, q_e, p_z = loads_by_letter["E"].tolist()
    p_g, q_g, p_t = loads_by_letter["G"].tolist()
    p_j, q_j, _ = loads_by_letter["J"].tolist()
    q_z = q_e - friction_coefficient * (p_e - p_z)
    q_t = q_g + friction_coefficient * (p_g - p_t)
    yield _line([p_z, p_e], [q_z, q_e], "gradient f through E and G", "c0 solid fine")
    yield _line([p_g, p_j], [q_g, q_j], "", "c0 solid fine")
    yield _line([p_t, p_g], [q_t, q_g], "gradient −f through G", "c2 dot")
    yield from _text_at(p_z, q_z, "Z", (-8.0, 6.0), "0", dot=True)
    yield from _text_at(p_t, q_t, "T", (-7.0, 7.0), "2", dot=True)


def _table_of_events(case: Case, loads_by_letter: Mapping[str, Array]) -> Table:
    """Columns of the CSV file of figure 2, with a row for each event in the order of time: letter,
    time, P, Q and the load at the stick edge. `loads_by_letter` has these loads (3,), over a third
    of the mean normal load.

    # notation: P normal load, Q tangential load
    """
    letters_in_order = sorted(case.events, key=case.time_of)
    loads_in_order = np.array([loads_by_letter[letter] for letter in letters_in_order])
    table: Table = {
        "letter": letters_in_order,
        "t": [case.time_of(letter) for letter in letters_in_order],
    }
    for name, column in zip(("P", "Q", "stick edge load"), loads_in_order.T, strict=True):
        table = {**table, f"{name} / (P0/3)": column.tolist()}
    return table


def _letters_around_ellipse(case: Case, loads_by_letter: Mapping[str, Array]) -> Iterator[Mark]:
    """The marks of the letters of the events in the plane of P and Q: each letter outside the
    ellipse, with a dot on it; letters at equal loads stand together.

    `loads_by_letter` is letter -> P, Q (and more), over P0/3, a third of the mean normal load.
    `case` is the paper's ellipse of loads on one profile; `unit_load` is P0/3.
    """
    # P and Q -> letters of the events at these loads
    letters_at_point: dict[tuple[float, float], list[str]] = {}
    # LETTERS: A to M
    for letter in LETTERS:
        p, q = loads_by_letter[letter][:2].round(6).tolist()
        letters_at_point.setdefault((p, q), []).append(letter)

    # the centre of the ellipse is at P0, which is 3 times P0/3, and the mean Q
    mean_q = case.load_ellipse.mean_tangential_load / case.unit_load
    for (p, q), letters in letters_at_point.items():
        vector_from_centre = np.array([p - 3.0, q - mean_q])
        outward_direction = vector_from_centre / np.hypot(*vector_from_centre)
        shift = (14.0 * float(outward_direction[0]), 12.0 * float(outward_direction[1]))
        yield from _text_at(p, q, ", ".join(letters), shift, dot=True)


def _figure_3(case: Case) -> Plate:
    """Figure 3: pressure and shear traction at the events A to M of the load cycle, a panel each;
    what slips is filled between zero and the Coulomb limit f p.

    `case` is the paper's ellipse of loads on one profile. Places are over a0, the contact
    half-width at the mean load P0 (`unit_length`), loads over P0/3 (`unit_load`).
    """
    # tractions over P0/(3 a0) at x/a0, (13, 251): LETTERS are A to M
    x = np.linspace(-1.25, 1.25, 251)
    times = [case.time_of(letter) for letter in LETTERS]
    solution = case.solve(time=times, x=x, fields=("pressure", "shear", "state"))
    traction_scale = case.unit_length / case.unit_load  # 1/stress
    limits_at_events = case.friction * solution.pressure * traction_scale
    shears_at_events = solution.shear * traction_scale
    loads_at_events = (
        np.column_stack([solution.normal_load, solution.tangential_load]) / case.unit_load
    )

    # a panel for each event
    x_axis = Axis(-1.25, 1.25, "x / a(P₀)")
    y_axis = Axis(-2.4, 2.4, "traction · a(P₀) / (P₀/3)")
    panels = []
    for letter, friction_limit, shear, state, (normal_load, tangential_load) in zip(
        LETTERS, limits_at_events, shears_at_events, solution.state, loads_at_events, strict=True
    ):
        # _line(x, y, label, look)
        marks: list[Mark] = [
            *_slip_bands_to_limit(x, friction_limit, state),
            _line(x, friction_limit, "f p", "faint solid"),
            _line(x, -friction_limit, "−f p", "faint dash"),
            _line(x, shear, "shear traction q", "shear-q"),
        ]
        title = f"{letter}   P = {normal_load:.2f}, Q = {tangential_load:.2f}"
        alt = f"Tractions at {letter}"
        panels.append(
            _panel(f"figure_03-{letter}", x_axis, y_axis, marks, alt, (270.0, 240.0), title)
        )

    # the CSV file
    table = {"x / a(P0)": x}
    table |= {
        f"f p at {letter}": friction_limit
        for letter, friction_limit in zip(LETTERS, limits_at_events, strict=True)
    }
    table |= {
        f"q at {letter}": shear for letter, shear in zip(LETTERS, shears_at_events, strict=True)
    }
    return _plate("figure_03", panels, table, n_columns=4)


def _slip_bands_to_limit(
    x: Array, friction_limit: Array, state: NDArray[np.int8]
) -> Iterator[Band]:
    """Coloured bands between zero and the Coulomb limit f p (`friction_limit`, (n,)) where points
    at `x` (n,) slip: up to +f p in forward slip, down to -f p in reverse slip. `state` (n,) is a
    `SurfaceState` each.
    """
    # _SLIP_LOOKS: look in the style sheet and label of a band, by the direction of slip
    for slip_state, sign in ((SurfaceState.SLIP_FORWARD, 1), (SurfaceState.SLIP_REVERSE, -1)):
        is_slipping = state == slip_state
        if is_slipping.any():
            css, label = _SLIP_LOOKS[sign]
            zero_line = np.where(is_slipping, 0.0, np.nan)
            limit_line = np.where(is_slipping, sign * friction_limit, np.nan)
            # Band: x, lower curve, upper curve, look, label
            yield Band(x, zero_line, limit_line, css, label)


# -------------------------------------------------------------------------------- contact and stick
@dataclass(frozen=True, eq=False)
class Zones:
    """Half-widths of contact and stick over a0, and the direction of slip, at instants; (n,) each.
    Instants at which slip begins, turns or ends stand there twice.
    """

    time: Array
    contact_edge: Array
    stick_edge: Array
    direction: NDArray[np.int64]  # 1 forward, -1 reverse, 0 where all sticks

    def marks(self, x: Array) -> Iterator[Mark]:
        """What is drawn of the zones of stick and slip over an abscissa `x` (n,): filled bands, and
        their edges as lines.
        """
        yield Band(x, np.zeros(len(x)), self.stick_edge, "pale-stick", "stick")
        yield from self.slip_bands(x)
        yield _line(x, self.contact_edge, "contact, a / a(P₀)", "bold")
        yield _line(x, self.stick_edge, "stick, c / a(P₀)", "c2 dash")

    def slip_bands(self, x: Array, label_end: str = "") -> Iterator[Band]:
        """A band for each direction of slip, between the stick edge and the contact edge, over an
        abscissa `x` (n,). `label_end` is added to its label in the legend.
        """
        for sign, (css, label) in _SLIP_LOOKS.items():
            is_slipping = self.direction == sign
            lower_line = np.where(is_slipping, self.stick_edge, np.nan)
            upper_line = np.where(is_slipping, self.contact_edge, np.nan)
            yield Band(x, lower_line, upper_line, css, label + label_end)

    def at_instants(self, is_kept: NDArray[np.bool_]) -> Zones:
        """The zones at those instants alone for which the mask (n,) is true."""
        return Zones(*(getattr(self, field.name)[is_kept] for field in fields(self)))

    def table(self, case: Case, x_head: str, x: Array) -> Table:
        """Columns of the figure's CSV file: the abscissa `x` (n,), headed `x_head`, then time,
        normal load, half-widths and direction of slip.
        """
        edges: Table = {
            "a / a(P0)": self.contact_edge,
            "c / a(P0)": self.stick_edge,
            "direction of slip": self.direction,
        }
        return {x_head: x, "t": self.time, "P / (P0/3)": case.scaled_loads(self.time)[0], **edges}


def _zones(case: Case, slip_events: Sequence[tuple[float, int]], n_instants: int = 91) -> Zones:
    """Half-widths of contact and stick through time, over a0 = a(P0), the contact half-width at the
    mean load, with the direction of slip.

    Parameters
    ----------
    case
        the paper's ellipse of loads on one profile; `unit_length` is a0
    slip_events
        instants at which slip begins, turns or ends, each with the direction of slip from there to
        the next one: 1 forward, -1 reverse, or 0 for stick
    n_instants
        number of instants from each event to the next, both events among them

    Returns
    -------
    Zones
        times, contact half-widths, stick half-widths and directions, one after the other, (n,) each
    """
    time = np.concatenate(
        [np.linspace(start, end, n_instants) for (start, _), (end, _) in pairwise(slip_events)]
    )
    # half-plane theory solves each instant once
    unique_times, unique_indices = np.unique(time, return_inverse=True)
    solution = case.solve(time=unique_times)
    contact_edge = solution.contact_half_width[unique_indices] / case.unit_length
    stick_edge = solution.stick_half_width[unique_indices] / case.unit_length
    # Each event stands there twice: as the end of the phase before, with theory's stick edge, and
    # as the start of the next phase, when all sticks.
    stick_edge[::n_instants] = contact_edge[::n_instants]
    directions = [direction for _, direction in slip_events[:-1]]
    return Zones(time, contact_edge, stick_edge, np.repeat(directions, n_instants))


def _slip_events(case: Case) -> list[tuple[float, int]]:
    """Instants at which slip begins or ends in a steady revolution from the event M on, each with
    the direction of slip after it: 1 forward, -1 reverse, or 0 for stick. M is the end of forward
    slip and the begin of reverse slip, which ends at G; forward slip begins at I.

    `case` is the paper's ellipse of loads on one profile; `time_of` gives the time of an event, of
    G and I a revolution before.
    """
    revolution = 2 * math.pi
    return [
        (case.time_of("M"), -1),
        (case.time_of("G") + revolution, 0),
        (case.time_of("I") + revolution, 1),
        (case.time_of("M") + revolution, 0),
    ]


def _figure_4a(case: Case) -> Plate:
    """Figure 4a: half-widths of contact and stick over the travel of the normal load P, the sum of
    the sizes of all its changes up to an instant. It grows where P falls too. The events are marked
    by their letters A to M.

    `case` is the paper's ellipse of loads on one profile. Loads are over P0/3, a third of the mean
    normal load (`unit_load`); half-widths over the contact half-width at the mean load.
    """
    # event -> direction of slip after it: 1 forward, -1 reverse, 0 stick
    direction_by_event = {"B": 1, "E": -1, "G": 0, "I": 1, "M": 0}
    start_of_loading = case.scene.load.path().start
    slip_events = [
        (start_of_loading, 0),
        *((case.time_of(letter), direction) for letter, direction in direction_by_event.items()),
    ]
    # Half-widths and directions of slip, with 181 instants between events. P turns at C, F and K,
    # at which slip neither begins nor ends: so many instants come near enough to them.
    zones = _zones(case, slip_events, 181)
    normal_load = case.scaled_loads(zones.time)[0]
    travel_of_p = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(normal_load)))])
    travel_by_letter = {
        letter: float(np.interp(case.time_of(letter), zones.time, travel_of_p))
        for letter in sorted(case.events)
    }

    # zones, with letters (_text_at) on the contact edge
    marks = list(zones.marks(travel_of_p))
    for letter, travel in travel_by_letter.items():
        marks += _text_at(travel, case.half_width_at(letter), letter, (0.0, 9.0), dot=True)
    x_axis = _axis_of_path(case, float(travel_of_p[-1]), travel_by_letter)
    alt = "Half-widths over the path of P"
    # _HALF_WIDTH: axis of half-widths
    panel = _panel("figure_04a", x_axis, _HALF_WIDTH, marks, alt, (820.0, 420.0))
    return _plate("figure_04a", [panel], zones.table(case, "way of P / (P0/3)", travel_of_p))


def _axis_of_path(
    case: Case, path_length: float, path_length_by_letter: Mapping[str, float]
) -> Axis:
    """The axis of the path of the normal load P, over P0/3, from 0 to just beyond its whole length.
    Its ticks state P itself: at 0, 1 and 2 of the first loading, and at eight events.
    `path_length_by_letter` is the length of the path up to each event of the `case`.

    # notation: P0 mean normal load
    """
    ticks = [(0.0, "0"), (1.0, "1"), (2.0, "2")]
    ticks += [
        (path_length_by_letter[letter], f"{case.events[letter].normal_load / case.unit_load:.3g}")
        for letter in "ACDFHKLM"
    ]
    words = "normal load P / (P₀/3), along its path"
    return Axis(0.0, path_length + 0.05, words, ticks=tuple(ticks))


def _figure_4b(case: Case) -> Plate:
    """Figure 4b: half-widths of contact and stick through the steady cycle for four coefficients of
    friction, with no mean shear force. The zones are filled for the least of them.

    `case` is the paper's ellipse of loads on one profile. Half-widths are over a0, the contact
    half-width at the mean load. The angle is counted from the event M, the end of forward slip, for
    f = 1.
    """
    # FRICTIONS: 1 first, then ever smaller
    cases = [case.with_zero_mean_shear(friction) for friction in FRICTIONS]
    case_of_largest_friction = cases[0]
    case_of_least_friction = cases[-1]
    time_of_m = case_of_largest_friction.time_of("M")
    filled_bands = _bands_from(time_of_m, case_of_least_friction)

    # From just after M: for f = 1 the instant of M itself still belongs to forward slip.
    angles = np.linspace(1e-6, 360.0, 721)
    times = time_of_m + np.radians(angles)
    stick_half_widths = [
        case_of_friction.solve(time=times).stick_half_width / case_of_friction.unit_length
        for case_of_friction in cases
    ]
    # _line(x, y, label, look); _CURVE_LOOKS: looks in the style sheet
    curves = [
        _line(angles, stick_half_width, f"c / a(P₀), f = {friction}", look)
        for friction, stick_half_width, look in zip(
            FRICTIONS, stick_half_widths, _CURVE_LOOKS, strict=True
        )
    ]
    contact_half_width = case.scaled_half_width(
        case_of_largest_friction.solve(time=times).normal_load
    )
    curves.append(_line(angles, contact_half_width, "contact, a / a(P₀)", "bold"))

    # _DEGREES: ticks, _HALF_WIDTH: axis of half-widths
    axis_words = "angle θ of the cycle after M for f = 1  [degrees]"
    x_axis = Axis(0.0, 360.0, axis_words, ticks=_DEGREES)
    alt = "Half-widths over the angle"
    panel = _panel("figure_04b", x_axis, _HALF_WIDTH, [*filled_bands, *curves], alt, (700.0, 430.0))
    table = {"theta [degrees]": angles, "a / a(P0)": contact_half_width}
    for friction, stick_half_width in zip(FRICTIONS, stick_half_widths, strict=True):
        table[f"c / a(P0), f = {friction}"] = stick_half_width
    return _plate("figure_04b", [panel], table)


def _bands_from(start_time: float, case: Case) -> list[Band]:
    """Zones of stick and slip of a case through a revolution, as filled bands over the angle in
    degrees, counted from `start_time`.

    The zones are known from an event M of the case (end of forward slip) to the next, so that two
    revolutions are needed to cover one from `start_time` on. `case` is the paper's ellipse of loads
    on one profile.
    """
    # instants at which slip begins or ends, each with the direction of slip after it; M, at the end
    # of the first revolution, begins the second
    first_revolution = _slip_events(case)
    second_revolution = [(time + 2 * math.pi, direction) for time, direction in first_revolution]
    # half-widths of stick and contact over those at the mean load, through both revolutions
    zones = _zones(case, [*first_revolution[:-1], *second_revolution])
    angles = np.degrees(zones.time - start_time)
    is_shown = (angles >= 0) & (angles <= 360)
    shown_zones = zones.at_instants(is_shown)
    shown_angles = angles[is_shown]
    label_end = f", f = {case.friction:g}"
    # Band: x, lower curve, upper curve, look, label
    stick_band = Band(
        shown_angles,
        np.zeros(len(shown_angles)),
        shown_zones.stick_edge,
        "pale-stick",
        f"stick{label_end}",
    )
    return [stick_band, *shown_zones.slip_bands(shown_angles, label_end)]


def _figure_5(case: Case) -> Plate:
    """Figure 5, in two panels over the angle of the steady cycle after the event M, the end of
    forward slip. Above: the half-widths of contact and stick, and the places of four points
    (`POINTS`). Below: the displacement of the four points, broad where they slip and dotted where
    they are out of contact.

    `case` is the paper's ellipse of loads on one profile. Lengths are over a0, the contact
    half-width at the mean load P0; displacements over A P0/3 (`unit_slip`), with A = 2/E*.
    """
    # displacement of the upper face over the lower since M, (721, 4)
    angles = np.linspace(0.0, 360.0, 721)
    times = case.time_of("M") + np.radians(angles)
    solution = case.solve(time=times, x=POINTS, fields=("slip", "state"))
    displacement = (solution.slip - solution.slip[0]) / case.unit_slip
    panels = [
        _panel_of_zones_and_points(case),
        _panel_of_displacements(angles, displacement, solution.state),
    ]

    # classes of the style sheet, and what they stand for
    looks = {
        "faint solid": "sticking",
        "forward broad-line": "slipping forward",
        "reverse broad-line": "slipping in reverse",
        "faint dot": "separated",
    }
    # Key: an entry of the legend, its look and text
    keys = [Key(css, text) for css, text in looks.items()]
    table: dict[str, Any] = {"theta [degrees]": angles}
    for x, point_displacement in zip(POINTS, displacement.T, strict=True):
        table[f"s/(A P0/3) at x = {x}"] = point_displacement
    for x, state in zip(POINTS, solution.state.T, strict=True):
        table[f"state at x = {x}"] = list(map(int, state))
    return _plate("figure_05", panels, table, keys=keys)


def _panel_of_zones_and_points(case: Case) -> Panel:
    """Upper panel of figure 5: half-widths of contact and stick through the steady cycle with the
    letters of its events, and the places of the four points as horizontal lines. Lengths are over
    a0, the contact half-width at the mean load.

    `case` is the paper's ellipse of loads on one profile.
    """
    # zones of stick and slip over the angle after M, the end of forward slip
    time_of_m = case.time_of("M")
    zones = _zones(case, _slip_events(case))
    marks = list(zones.marks(np.degrees(zones.time - time_of_m)))

    # the letters on the contact edge, each with a dot (_text_at); F to L belong to the revolution
    # after M
    text_shifts = {"M": (8.0, 9.0), "I": (0.0, -12.0), "J": (-6.0, -12.0)}
    for letter in "MFGHIKJL":
        time = case.time_of(letter)
        time_after_m = time + (2 * math.pi if time < time_of_m else 0.0) - time_of_m
        marks += _text_at(
            math.degrees(time_after_m),
            case.half_width_at(letter),
            letter,
            text_shifts.get(letter, (0.0, 9.0)),
            dot=True,
        )

    # the points at x
    # POINTS: x/a0 of the four points; _POINT_COLOURS: their colours in the style sheet
    for x, colour in zip(POINTS, _POINT_COLOURS, strict=True):
        # _line(x, y, label, look), _text_at(x, y, text, shift, colour)
        marks.append(_line([0.0, 360.0], [x, x], "", f"{_curve_class(colour)} dot"))
        marks += _text_at(360.0, x, f"{x:.2f}", (-14.0, 5.0), colour)
    y_axis = Axis(0.5, 1.28, "x / a(P₀)")
    # _REVOLUTION: axis of the angle, 0 to 360 degrees
    return _panel(
        "figure_05-zones", _REVOLUTION, y_axis, marks, "Zones over the angle", (760.0, 330.0)
    )


def _panel_of_displacements(angles: Array, displacement: Array, states: NDArray[np.int8]) -> Panel:
    """Lower panel of figure 5: the displacements of four points (n, 4) over A P0/3, at angles (n,)
    of the cycle in degrees. `states` (n, 4) is a `SurfaceState` each. A = 2/E*, P0 is the mean
    normal load.
    """
    # a line for each point at x (`POINTS`), with x written at its least displacement (_text_at)
    marks: list[Mark] = []
    # _POINT_COLOURS: colours of the points in the style sheet
    for x, colour, point_displacement, point_states in zip(
        POINTS, _POINT_COLOURS, displacement.T, states.T, strict=True
    ):
        marks += _displacement_line(angles, point_displacement, point_states, _curve_class(colour))
        least_index = int(np.argmin(point_displacement))
        marks += _text_at(
            float(angles[least_index]),
            float(point_displacement[least_index]),
            f"{x:.2f}",
            (0.0, -10.0),
            colour,
        )
    least_displacement = float(displacement.min())
    largest_displacement = float(displacement.max())
    displacement_range = largest_displacement - least_displacement
    y_axis = Axis(
        least_displacement - 0.12 * displacement_range,
        largest_displacement + 0.08 * displacement_range,
        "displacement / (A P₀/3)",
    )
    alt = "Displacement of four points over the angle"
    # _REVOLUTION: axis of the angle, 0 to 360 degrees
    return _panel("figure_05-slip", _REVOLUTION, y_axis, marks, alt, (760.0, 360.0))


def _curve_class(colour: str) -> str:
    """Class of the style sheet for a curve in the colour of a point of figure 5."""
    return colour if colour == "d" else f"c{colour}"


def _with_neighbours(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask (n,) with one instant more at either end of each run of true ones, so that curves
    meet; (n,). The last instant and the first are neighbours.
    """
    return np.asarray(mask | np.roll(mask, 1) | np.roll(mask, -1))


def _displacement_line(
    angles: Array, displacement: Array, states: NDArray[np.int8], css: str
) -> Iterator[Mark]:
    """The displacement of a point through the cycle as curves over the angle, (n,) each: broad
    where it slips, dotted where it is out of contact. `states` (n,) is a `SurfaceState` each, `css`
    the look of the curve where the point sticks.
    """
    for slip_state, direction in (
        (SurfaceState.SLIP_FORWARD, "forward"),
        (SurfaceState.SLIP_REVERSE, "reverse"),
    ):
        is_slipping = states == slip_state
        if is_slipping.any():
            # so that curves meet, with an instant more at either end
            displacement_in_slip = np.where(_with_neighbours(is_slipping), displacement, np.nan)
            # _line(x, y, label, look)
            yield _line(angles, displacement_in_slip, "", f"{direction} broad-line")
    is_open = states == SurfaceState.OPEN
    yield _line(angles, np.where(is_open, np.nan, displacement), "", css)
    yield _line(angles, np.where(_with_neighbours(is_open), displacement, np.nan), "", f"{css} dot")


def _figure_8(case: Case) -> Plate:
    """Figure 8: half-widths of contact and stick of the flat and rounded contact through the steady
    cycle, over the angle after the event M (end of forward slip). Half-widths are over a0, the
    contact half-width at the mean load. `case` is the paper's ellipse of loads on this profile.
    """
    # half-widths of contact and stick, and direction of slip, at many instants of a revolution
    zones = _zones(case, _slip_events(case))
    # without load the contact is as wide as the flat
    flat_half_width = float(case.scaled_half_width(0.0))
    angles = np.degrees(zones.time - case.time_of("M"))
    # _line(x, y, label, look)
    marks = [
        *zones.marks(angles),
        _line(
            [0.0, 360.0], [flat_half_width, flat_half_width], "edge of flat, b / a(P₀)", "c1 dot"
        ),
    ]
    alt = "Half-widths over the angle"
    # _REVOLUTION: axis of the angle; _HALF_WIDTH: axis of half-widths
    panel = _panel("figure_08", _REVOLUTION, _HALF_WIDTH, marks, alt, (700.0, 420.0))
    return _plate(
        "figure_08",
        [panel],
        zones.table(case, "theta [degrees]", angles),
        flat=flat_half_width,
        friction=case.friction,
    )


# --------------------------------------------------------------------------------------------- work
def _figure_of_density(name: str, case: Case, peak: PeakBatch) -> Plate:
    """Figures 6 and 9: dissipation per area W(x) of a steady cycle over A f^2 P0^2/a0, and the part
    of each phase of slip. The phases, from event to event, are "EG" reverse, "IJ" and "JM" forward.

    # notation: a0 contact half-width at the mean normal load P0, A = 2/E*, f friction

    `case` is the paper's ellipse of loads on one profile: its half-widths are over a0
    (`unit_length`), and `unit_work` is A f^2 P0^2. `peak` has the place [length] and value
    [energy per area] of the largest W(x), and the fraction of the way from the stick edge to the
    contact edge at which it lies.
    """
    # x/a0 of the slip zone, and a point beyond either edge of it
    stick_edge = case.permanent_stick_half_width
    contact_edge = case.largest_half_width
    x_min = 0.95 * stick_edge
    x_max = contact_edge + 0.05 * stick_edge
    # points closer together at both edges
    fractions = (1 - np.cos(np.linspace(0, np.pi, 241))) / 2
    x = np.concatenate([[x_min], stick_edge + (contact_edge - stick_edge) * fractions, [x_max]])

    # W(x) by phases, and its peak
    density_by_phase = case.density_of_phases(x)
    density = sum_over_phases(density_by_phase)
    peak_fraction = float(peak.fraction)
    peak_x_over_a0 = float(peak.place) / case.unit_length
    scaled_peak_value = float(peak.value) * case.unit_length / case.unit_work
    # _line(x, y, label, look), _text_at(x, y, text, shift)
    marks: list[Mark] = [
        _line(x, density, "whole cycle", "bold"),
        _line(x, density_by_phase["IJ"], "forward, I–J", "c1 dash"),
        _line(x, density_by_phase["JM"], "forward, J–M", "c4 dashdot"),
        _line(x, density_by_phase["EG"], "reverse, E–G", "c0 dot"),
        *_edges_of_slip_zone(stick_edge, contact_edge, 1.12 * scaled_peak_value),
        *_text_at(
            peak_x_over_a0,
            scaled_peak_value,
            f"{peak_fraction:.1%} of the way",
            (0.0, 10.0),
            dot=True,
        ),
    ]
    x_axis = Axis(x_min, x_max, "x / a(P₀)")
    y_axis = Axis(0.0, 1.22 * scaled_peak_value, "W(x) · a(P₀) / (A f² P₀²)")
    panel = _panel(name, x_axis, y_axis, marks, "Pointwise dissipation over x", (640.0, 400.0))
    table = {"x / a(P0)": x, "W a(P0)/(A f^2 P0^2)": density}
    table |= {f"in {phase}": density_by_phase[phase] for phase in ("IJ", "JM", "EG")}
    return _plate(name, [panel], table, fraction=peak_fraction, place=peak_x_over_a0)


def _edges_of_slip_zone(stick_edge: float, contact_edge: float, height: float) -> Iterator[Mark]:
    """Upright lines up to a height of the panel at the stick edge and at the edge of contact, with
    their places above them. Both edges are over the half-width at the mean load.
    """
    for edge in (stick_edge, contact_edge):
        yield _line([edge, edge], [0.0, height], "", "faint dot fine")
    stick_text = f"stick edge {stick_edge:.3f}"
    contact_text = f"edge of contact {contact_edge:.3f}"
    yield from _text_at(stick_edge, height, stick_text, (42.0, 6.0), text_class="tick")
    yield from _text_at(contact_edge, height, contact_text, (-50.0, 6.0), text_class="tick")


def _figure_of_sweep(
    name: str, quantity: str, sweep: Sweep, pale_sweep: Sweep | None = None
) -> Plate:
    """Figures 7 and 10: a cycle's dissipation W, or the largest dissipation per area W(x), as
    curves over P0/P1, one for each coefficient of friction f. P0 is the mean normal load, P1 the
    amplitude of P and of Q.

    `quantity` is "work" or "peak", an array of `sweep`: friction along rows, `load_ratio` P0/P1
    along columns. The curves of `pale_sweep`, the Hertz contact, lie beneath as pale lines, if it
    is given.
    """
    label = {"work": "W / (A P₁²)", "peak": "max W(x) · a(P₀) / (A P₁²)"}[quantity]
    curves = getattr(sweep, quantity)
    largest_value = float(curves.max())

    # the pale curves first, so that they lie beneath
    marks: list[Mark] = []
    if pale_sweep is not None:
        pale_curves = getattr(pale_sweep, quantity)
        largest_value = max(largest_value, float(pale_curves.max()))
        for curve_number, (load_ratios, pale_curve) in enumerate(
            zip(pale_sweep.load_ratio, pale_curves, strict=True)
        ):
            # one label stands for all pale lines
            pale_label = "" if curve_number else "Hertz, same f"
            # _line(x, y, label, look)
            marks.append(_line(load_ratios, pale_curve, pale_label, "faint solid fine"))

    # a curve for each coefficient of friction, with a dot at its begin, near gross sliding
    for curve_number, (friction, load_ratios, curve) in enumerate(
        zip(sweep.frictions, sweep.load_ratio, curves, strict=True)
    ):
        # _CURVE_LOOKS: look of each curve in the style sheet
        marks.append(_line(load_ratios, curve, f"f = {friction:g}", _CURVE_LOOKS[curve_number]))
        marks += _text_at(
            float(load_ratios[0]), float(curve[0]), "", colour=f"{curve_number}", dot=True
        )
    x_axis = Axis(1.0, float(sweep.load_ratio.max()), "P₀ / P₁")
    y_axis = Axis(0.0, 1.08 * largest_value, label)
    panel = _panel(name, x_axis, y_axis, marks, f"{label} over P₀/P₁", (620.0, 400.0))

    table = {
        f"P0/P1, f = {friction:g}": load_ratios
        for friction, load_ratios in zip(sweep.frictions, sweep.load_ratio, strict=True)
    }
    for friction, curve in zip(sweep.frictions, curves, strict=True):
        table[f"{quantity}, f = {friction:g}"] = curve
    return _plate(name, [panel], table)
