"""Figures over x: tractions, the instant that the slider moves, states and dissipation density."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import (
    STATE_KEYS,
    Axis,
    Bitmap,
    Block,
    Cell,
    Curve,
    Dot,
    Group,
    Key,
    Mark,
    Note,
    Panel,
    Plate,
    Rule,
    axis_limits,
    figure_with_texts,
)
from reports.charts.templating import STATE_NAMES
from reports.comparison.words import value_in_words
from reports.page.cycle_view import (
    ZERO,
    CycleView,
    EngineView,
    difference_in_words,
    permanent_edges,
)
from reports.units import minus, signed
from scenes.array_types import Array

# Open, stick, forward and reverse slip on a map, which has no style sheet.
_STATE_COLOURS = ("#ffffff", "#d2d2d2", "#e69f00", "#0072b2")
_DIFFERENCE_COLOURS = ("#ffffff", "#111111")  # where states agree, where they differ
# Pixels of a map.
_MAP_COLUMNS = 440
_MAP_ROWS = 360

# Rows of the table of states: of a long path evenly many instants, 25 MB.
_MOST_STATES = 500_000


def traction_keys(view: CycleView) -> tuple[Key, ...]:
    """Legend: p and q of each engine, then the differences."""
    keys = [
        Key(f"{engine.line_css} {letter}", f"{letter}, {engine.name}")
        for engine in view.engines
        for letter in "pq"
    ]
    return (*keys, Key("d p", "difference of p"), Key("d q", "difference of q"))


def tractions(view: CycleView) -> Plate:
    """A figure of pressure p and shear q of both engines over x, two panels for each numbered
    instant: the tractions, and their difference.

    `view` holds the last cycles of both solutions, with tractions (k instants, n points). Its
    points `x` are over a_ref, the half-width at the reference load; `chosen_events` are the
    numbered instants, each with index and label.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. A
    `Cell` is a stack of panels.
    """
    instant_indices = [event.index for event in view.chosen_events]
    cells = []
    for number, event in enumerate(view.chosen_events, start=1):
        panels = traction_panels(
            view,
            event.index,
            instant_indices,
            f"event-{number}",
            (320.0, 220.0),
            f"{number}  {event.label}",
        )
        cells.append(Cell(panels, event.index))  # a click on it shows that instant
    table = {
        "time": np.repeat(view.result_cycle.time[instant_indices], len(view.x)),
        "x": np.tile(view.result_cycle.x, len(instant_indices)),
        "x/a_ref": np.tile(view.x, len(instant_indices)),
    }
    name_of_scale = {"p": "p_ref", "q": "(f p_ref)"}
    # letter of a traction -> its name in a cycle, and the number that it is divided by
    for letter, (field, scale) in _traction_fields(view).items():
        for role, cycle in (("reference", view.reference_cycle), ("result", view.result_cycle)):
            column_name = f"{letter}_{role}/{name_of_scale[letter]}"
            table[column_name] = (getattr(cycle, field)[instant_indices] / scale).ravel()
    return figure_with_texts("tractions", cells, table, traction_keys(view), columns=3)


def _traction_fields(view: CycleView) -> dict[str, tuple[str, float]]:
    """By letter p or q: the name of the traction's field, and the scale that it is divided by,
    p_ref or f p_ref [stress].
    """
    return {"p": ("pressure", view.scales.pressure), "q": ("shear", view.scales.shear)}


def traction_panels(
    view: CycleView,
    instant: int,
    instants_of_axes: Sequence[int],
    name: str,
    size: tuple[float, float],
    title: str = "",
    *,
    moves_with_slider: bool = False,
) -> tuple[Panel, Panel]:
    """Two panels for one instant: pressure p and shear q of both engines over x; and below it the
    difference, result minus reference, in per cent of p_ref (reference pressure) and f p_ref (f the
    friction coefficient).

    Parameters
    ----------
    view
        last cycles of reference and result, and the range of x that figures share
    instant
        index of the instant that is drawn
    instants_of_axes
        indices of the instants whose tractions fit on the axes, the same for all panels of a figure
    name
        name of the upper panel
    size
        width and height of the upper panel [pixels]
    title
        title of the upper panel
    moves_with_slider
        whether the curves change to the instant that the page's slider chooses
    """
    width, height = size
    # x/a_ref (n,); by letter p or q: reference and result, (instants, n), the drawn instant first
    x, traction_pairs = _tractions_at(view, (instant, *instants_of_axes))
    differences = {
        letter: 100 * (result_values - reference_values)
        for letter, (reference_values, result_values) in traction_pairs.items()
    }

    def curve_of(values: Array, css: str, label: str, field: str) -> Curve:
        """A curve over x; the slider replaces it by values of `field` in the page's script."""
        data_of_slider = {"field": field} if moves_with_slider else {}
        return Curve(x, values.copy(), css, label, data_of_slider)

    # `ZERO` is a line at zero; `line_css` the class of an engine's lines in the style sheet. Row 0
    # is the instant that is drawn. Its curves are copies of the row: a view of it would keep the
    # tractions of all instants in memory.
    traction_marks: list[Mark] = [ZERO]
    for engine_number, engine in enumerate(view.engines):
        for letter in "pq":
            values = traction_pairs[letter][engine_number][0]
            css = f"{engine.line_css} {letter}"
            label = f"{letter}, {engine.name}"
            traction_marks.append(curve_of(values, css, label, f"{letter}{engine_number}"))
    all_values = [values for pair in traction_pairs.values() for values in pair]
    upper_panel = Panel(
        name,
        view.over_x(""),
        Axis(*axis_limits(*all_values, with_zero=True), "p/p_ref,  q/(f p_ref)"),
        traction_marks,
        f"Pressure and shear over x. {title}".strip(),
        width,
        height,
        title,
        room=(72.0, 26.0 if title else 12.0, 20.0, 20.0),
    )

    pressure_of_reference, pressure_of_result = traction_pairs["p"]
    is_touching = (pressure_of_reference[0] != 0) | (pressure_of_result[0] != 0)
    difference_marks: list[Mark] = [ZERO]
    notes = []
    for letter in "pq":
        values = differences[letter][0]
        label = f"difference of {letter}, %"
        difference_marks.append(curve_of(values, f"d {letter}", label, f"d{letter}"))
        size_in_words = difference_in_words(values, x, "x = {} a_ref", " %", is_touching)
        notes.append(f"{letter}: {size_in_words}")
    lower_panel = Panel(
        f"{name}-difference",
        view.over_x(),
        Axis(
            *axis_limits(*differences.values(), with_zero=True, least_range=1e-9),
            "difference, %",
            count=3,
        ),
        difference_marks,
        f"Result less reference over x. {title}".strip(),
        width,
        0.56 * height + 56,
        notes=notes,
    )
    return upper_panel, lower_panel


def _tractions_at(
    view: CycleView, instants: Sequence[int]
) -> tuple[Array, dict[str, tuple[Array, Array]]]:
    """The x/a_ref of the points that are drawn, (n,); and by letter, "p" or "q", a pair of arrays
    (k, n): p/p_ref or q/(f p_ref) of the reference and of the result at these points.

    The k instants are `instants` (indices) in their order, without repetitions. `view` holds the
    last cycles of both solutions, all points over a_ref, and the largest that is drawn.

    # notation: p pressure, q shear traction, p_ref and a_ref pressure and half-width at the
    # reference load, f friction coefficient
    """
    is_drawn = np.abs(view.x) <= view.largest_x * 1.02
    instants_once = np.array(list(dict.fromkeys(instants)))
    grid = np.ix_(instants_once, np.flatnonzero(is_drawn))
    traction_pairs = {}
    for letter, (field, scale) in _traction_fields(view).items():
        reference_values = getattr(view.reference_cycle, field)[grid] / scale
        result_values = getattr(view.result_cycle, field)[grid] / scale
        traction_pairs[letter] = (reference_values, result_values)
    return view.x[is_drawn], traction_pairs


def moving_instant(view: CycleView) -> Plate:
    """The figure that the slider moves: p and q of both engines over x at one instant, their
    difference, and their states along x. At first it shows the instant with most slip. Its axes fit
    the whole cycle.

    `view` holds the last cycles of both solutions with their loads, displacements U (k,) and states
    (k, n), and the index of the instant that is shown first.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.
    """
    width = 560.0
    every_instant = range(len(view.result_cycle.time))
    traction_panel, difference_panel = traction_panels(
        view,
        view.shown_instant,
        every_instant,
        "now",
        (width, 300.0),
        moves_with_slider=True,
    )
    marks: list[Mark] = []
    for strip_number, engine in enumerate(view.engines):
        marks += _strip_of_states(view, engine, strip_number)
    state_panel = Panel(
        "zones",
        view.over_x(""),
        Axis(84.0, 0.0, ""),
        marks,
        "Open, stick and slip along x, a strip for each engine",
        width,
        84.0,
        css="zones",
        without_axes=True,
        room=(72.0, 0.0, 20.0, 0.0),
    )
    states_differ = view.reference_cycle.state != view.result_cycle.state
    table = {
        "time": view.result_cycle.time,
        "fraction": view.result_cycle.fraction,
        "P": view.result_cycle.normal_load,
        "Q": view.result_cycle.tangential_load,
        "U_reference": view.reference_cycle.tangential_displacement,
        "U_result": view.result_cycle.tangential_displacement,
        "points_where_states_differ": states_differ.sum(axis=1).astype(np.int64),
    }
    panels = (traction_panel, state_panel, difference_panel)
    return figure_with_texts("cycle", panels, table, traction_keys(view), columns=1)


def _strip_of_states(view: CycleView, engine: EngineView, strip_number: int) -> Iterator[Mark]:
    """What is drawn for one engine's contact states at the instant shown: a strip along x, coloured
    by open, stick and slip, with the engine's name. The page's slider recolours it.

    `strip_number` counts from 0 at the top. `view` holds the instant that is shown, and the largest
    x that is drawn, over the half-width at the reference load; `engine` its last cycle, with states
    (k, n) as codes 0 to 3. Heights are in pixels.

    `Block` is a rectangle, `Note` a text and `Group` marks that the page's script replaces
    together.
    """
    top_y = 20.0 + 40.0 * strip_number
    bottom_y = top_y + 16
    x = engine.cycle.x / view.scales.half_width
    state_of_points = engine.cycle.state[view.shown_instant]
    # A state ends midway between two points of different states.
    last_points = np.flatnonzero(np.diff(state_of_points))  # index of the last point of each state
    midpoints = (x[last_points + 1] + x[last_points]) / 2
    boundaries = np.clip(midpoints, -view.largest_x, view.largest_x)
    ends = [-view.largest_x, *boundaries.tolist(), view.largest_x]
    states_of_blocks = state_of_points[[0, *(last_points + 1).tolist()]].tolist()
    blocks = []
    for left_end, right_end, state_code in zip(ends[:-1], ends[1:], states_of_blocks, strict=True):
        if right_end > left_end:
            blocks.append(Block((left_end, right_end), (top_y, bottom_y), f"state-{state_code}"))
    yield Note(-view.largest_x, top_y - 5, engine.name)
    yield Group(tuple(blocks), "strip", {"strip": strip_number, "top": f"{top_y:g}"})
    yield Block((-view.largest_x, view.largest_x), (top_y, bottom_y), "outline")


def state_map(view: CycleView) -> Plate:
    """A figure of open, stick, forward and reverse slip over x and time: a map for each engine, and
    one of where they differ.

    `view` holds the last cycles of both solutions, with states (k instants, n points) as codes 0 to
    3, and the instants `time` (k,). Its points `x` (n,) are over the half-width at the reference
    load; `largest_x` is the largest that is drawn.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Bitmap`
    is an image over the panel.
    """
    states_of_reference = view.reference_cycle.state
    states_of_result = view.result_cycle.state
    metric = view.comparison.metric("state")
    # The share of points that differ is that of the metric, weighted by lengths. Points crowd at
    # the edges, so that counting them would give a larger share.
    share_in_words = "" if metric.value is None else value_in_words(metric)
    reference_engine, result_engine = view.engines
    difference_title = f"they differ: {share_in_words}".rstrip(": ")
    # name of the panel, values (k, n), colour of each value, title
    maps = (
        ("map-reference", states_of_reference, _STATE_COLOURS, reference_engine.name),
        ("map-result", states_of_result, _STATE_COLOURS, result_engine.name),
        (
            "map-difference",
            states_of_reference != states_of_result,
            _DIFFERENCE_COLOURS,
            difference_title,
        ),
    )
    pixels = _pixels(view)  # the instant and the point of each pixel of a map
    panels = []
    for name, states, palette, title in maps:
        marks = [Bitmap(states[pixels].astype(np.uint8), palette)]
        panels.append(
            Panel(
                name,
                view.over_x(),
                view.over_time(),
                marks,
                f"Map of states: {title}",
                340.0,
                320.0,
                title,
                time="y",
                css="pick",
            )
        )

    # the table of all states; of a long path evenly many instants, half a million states in all
    point_indices = np.flatnonzero(np.abs(view.x) <= view.largest_x)
    instant_count = min(len(view.time), max(_MOST_STATES // len(point_indices), 2))
    instant_indices = np.linspace(0, len(view.time) - 1, instant_count).round().astype(int)
    grid = np.ix_(instant_indices, point_indices)
    # STATE_NAMES: code of a state -> its name, such as 1 -> "stick"
    codes = ", ".join(f"{int(state)} {state_name}" for state, state_name in STATE_NAMES.items())
    table = {
        "time": np.repeat(view.result_cycle.time[instant_indices], len(point_indices)),
        "x": np.tile(view.result_cycle.x[point_indices], len(instant_indices)),
        f"state_reference ({codes})": states_of_reference[grid].ravel(),
        f"state_result ({codes})": states_of_result[grid].ravel(),
    }
    # with the legend of the four states; the arguments after `columns` fill the caption
    return figure_with_texts(
        "state_map",
        panels,
        table,
        STATE_KEYS,
        columns=3,
        share=share_in_words,
        written=len(instant_indices),
        instants=len(view.time),
        stretch=view.part_of_path,
    )


def _pixels(view: CycleView) -> tuple[NDArray[np.int_], ...]:
    """Index arrays that pick from values (k instants, n points) those of the rows and columns of a
    map: of the instant and of the point nearest to each. Time goes up. A map has 440 columns and
    360 rows. `view.time` (k,) are the instants, `view.x` (n,) the points over a_ref.
    """
    x_of_columns = np.linspace(-view.largest_x, view.largest_x, _MAP_COLUMNS)
    point_indices = np.abs(view.x[:, None] - x_of_columns).argmin(axis=0)
    time_of_rows = np.linspace(view.time[-1], view.time[0], _MAP_ROWS)
    instant_indices = np.abs(view.time[:, None] - time_of_rows).argmin(axis=0)
    return np.ix_(instant_indices, point_indices)


def dissipation_density(view: CycleView) -> Plate | None:
    """A figure of the friction work per area w(x) of the last cycle, both engines, and of their
    difference in per cent of the largest w of the reference. None where nothing is dissipated.

    `view` holds the last cycles of both solutions, with w (n,) at the points `x` over a_ref. The
    scale of w is A f^2 P_ref^2/a_ref: A = 2/E* the compliance of the materials, f the friction
    coefficient, P_ref and a_ref load and half-width of the reference.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Rule`
    is a line across the panel, `Key` an entry of the legend and `ZERO` a line at 0. `css` is a
    class of the style sheet.
    """
    x = view.x
    scales = view.scales
    scale_of_density = scales.dissipation / scales.half_width
    density_of_reference = view.reference_cycle.dissipation_density / scale_of_density
    density_of_result = view.result_cycle.dissipation_density / scale_of_density
    if not (np.any(density_of_reference) or np.any(density_of_result)):
        return None

    # ends of the zone that sticks through the whole cycle, over a_ref; NaN without one
    stick_edges = permanent_edges(view.comparison.reference) / scales.half_width
    density_marks: list[Mark] = [
        Rule(float(edge), "stick-line", is_upright=True)
        for edge in stick_edges
        if np.isfinite(edge)
    ]
    for density, key in zip((density_of_reference, density_of_result), view.keys, strict=True):
        density_marks.append(Curve(x, density, key.css, key.text))
    known_density = np.where(np.isfinite(density_of_result), density_of_result, -np.inf)
    peak_index = int(np.nanargmax(known_density))
    density_marks.append(Dot(float(x[peak_index]), float(density_of_result[peak_index]), "event"))
    density_panel = Panel(
        "work",
        view.over_x(),
        Axis(
            *axis_limits(density_of_reference, density_of_result, with_zero=True),
            "w / (A f² P_ref²/a_ref)",
        ),
        density_marks,
        "Dissipation density over x",
        css="pick",
    )

    largest_density = float(np.nanmax(np.abs(density_of_reference), initial=0.0)) or 1.0
    difference = 100 * (density_of_result - density_of_reference) / largest_density
    has_dissipation = (density_of_reference != 0) | (density_of_result != 0)
    note = difference_in_words(
        difference, x, "x = {} a_ref", " %", (np.abs(x) <= view.largest_x) & has_dissipation
    )
    difference_panel = Panel(
        "work-difference",
        view.over_x(),
        Axis(
            *axis_limits(difference, with_zero=True, least_range=1e-9),
            "difference, % of the largest",
        ),
        [ZERO, Curve(x, difference, "d p", "difference")],
        "Difference of the dissipation density",
        notes=[note],
    )
    scale_in_words = "(A f^2 P_ref^2/a_ref)"
    table = {
        "x": view.result_cycle.x,
        "x/a_ref": x,
        f"w_reference/{scale_in_words}": density_of_reference,
        f"w_result/{scale_in_words}": density_of_result,
    }
    # the arguments after the legend fill the caption
    # `signed`: as text, to four digits
    return figure_with_texts(
        "dissipation_density",
        (density_panel, difference_panel),
        table,
        (*view.keys, Key("d p", "difference")),
        stretch=view.part_of_path,
        peak=f"{density_of_result[peak_index]:.4g}",
        place=signed(float(x[peak_index])),
        stick=_ends_in_words(stick_edges),
    )


def _ends_in_words(ends: Array) -> str:
    """Both ends of the permanent stick zone over a_ref; nothing where there is none."""
    left_end, right_end = ends
    if not np.isfinite(ends).all():
        return ""
    if left_end == -right_end:
        return f"±{right_end:.4g}"
    return minus(f"{left_end:.4g} and {right_end:.4g}")
