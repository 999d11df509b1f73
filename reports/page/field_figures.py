"""Figures over x: tractions, the instant that the slider moves, states and dissipation density."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

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
from reports.charts.templating import STATE_NAMES, Table
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
    for event_number, event in enumerate(view.chosen_events, start=1):
        panels = traction_panels(
            view,
            event.index,
            instant_indices,
            f"event-{event_number}",
            (320.0, 220.0),
            f"{event_number}  {event.label}",
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
    return figure_with_texts("tractions", cells, table, traction_keys(view), n_columns=3)


def _traction_fields(view: CycleView) -> dict[str, tuple[str, float]]:
    """By letter p or q: the name of the traction's field, and the scale that it is divided by,
    p_ref or f p_ref [stress].
    """
    return {"p": ("pressure", view.scales.pressure), "q": ("shear", view.scales.shear)}


class _DrawnTractions(NamedTuple):
    """Tractions of both engines at the points and instants that a figure needs.

    p is the pressure and q the shear. They are divided by p_ref, the pressure at the reference
    load, and by f p_ref, f the friction coefficient.
    """

    x: Array  # (n,) points over a_ref, the half-width at the reference load
    # "p" or "q" -> of the reference and of the result, (k instants, n) each; the instant that is
    # drawn is the first, the others are there for the ends of the axes
    pairs: dict[str, tuple[Array, Array]]


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
    drawn = _tractions_at(view, (instant, *instants_of_axes))
    all_values = [values for pair in drawn.pairs.values() for values in pair]
    # Panel: name, both axes, marks, description, width, height and title
    upper_panel = Panel(
        name,
        view.over_x(""),
        Axis(*axis_limits(*all_values, with_zero=True), "p/p_ref,  q/(f p_ref)"),
        _traction_curves(view, drawn, moves_with_slider=moves_with_slider),
        f"Pressure and shear over x. {title}".strip(),
        width,
        height,
        title,
        room=(72.0, 26.0 if title else 12.0, 20.0, 20.0),
    )
    difference_by_letter = {
        letter: 100 * (result_values - reference_values)
        for letter, (reference_values, result_values) in drawn.pairs.items()
    }
    lower_panel = Panel(
        f"{name}-difference",
        view.over_x(),
        Axis(
            *axis_limits(*difference_by_letter.values(), with_zero=True, least_range=1e-9),
            "difference, %",
            n_ticks=3,
        ),
        _difference_curves(drawn.x, difference_by_letter, moves_with_slider=moves_with_slider),
        f"Result minus reference over x. {title}".strip(),
        width,
        0.56 * height + 56,
        notes=_differences_in_words(drawn, difference_by_letter),
    )
    return upper_panel, lower_panel


def _curve_over_x(
    x: Array, values: Array, css: str, label: str, series_of_slider: str | None
) -> Curve:
    """A curve of `values` (n,) over `x` (n,) with a label, in the look of a class of the style
    sheet. Where the page's slider moves it, `series_of_slider` is the name of its values in the
    data of the page's script; else None.

    The values are copied: a view of one instant would keep those of all instants in memory.
    """
    data_of_slider = {} if series_of_slider is None else {"field": series_of_slider}
    return Curve(x, values.copy(), css, label, data_of_slider)


def _traction_curves(
    view: CycleView, drawn: _DrawnTractions, *, moves_with_slider: bool
) -> list[Mark]:
    """A line at zero, and the curves of p and q of both engines over x at the first instant of
    `drawn`. With `moves_with_slider` the page's slider replaces each curve by one of the series
    "p0" and "q0" (reference), "p1" and "q1" (result) of the page's script.

    `view` holds names and looks of both engines.
    """
    # `ZERO` is a line at zero; `line_css` the class of an engine's lines in the style sheet
    marks: list[Mark] = [ZERO]
    for engine_number, engine in enumerate(view.engines):
        for letter in "pq":
            values_at_instants = drawn.pairs[letter][engine_number]  # (k, n)
            css = f"{engine.line_css} {letter}"
            series_of_slider = f"{letter}{engine_number}" if moves_with_slider else None
            label = f"{letter}, {engine.name}"
            marks.append(
                _curve_over_x(drawn.x, values_at_instants[0], css, label, series_of_slider)
            )
    return marks


def _difference_curves(
    x: Array, difference_by_letter: Mapping[str, Array], *, moves_with_slider: bool
) -> list[Mark]:
    """A line at zero, and the curves of the differences of p and q over `x` (n,), in per cent, at
    the first instant of each array (k, n). With `moves_with_slider` the page's slider replaces them
    by the series "dp" and "dq" of the page's script.

    `difference_by_letter`: "p" or "q" -> difference.
    """
    marks: list[Mark] = [ZERO]
    for letter in "pq":
        values_at_first_instant = difference_by_letter[letter][0]
        label = f"difference of {letter}, %"
        series_of_slider = f"d{letter}" if moves_with_slider else None
        marks.append(
            _curve_over_x(x, values_at_first_instant, f"d {letter}", label, series_of_slider)
        )
    return marks


def _differences_in_words(
    drawn: _DrawnTractions, difference_by_letter: Mapping[str, Array]
) -> list[str]:
    """The sizes of the differences of p and of q at the first instant, in words: root mean square,
    largest value and its place. They count where either engine has pressure.
    `difference_by_letter`: "p" or "q" -> difference (k, n) in per cent.

    `drawn` has the points and the tractions of both engines.
    """
    pressure_of_reference, pressure_of_result = drawn.pairs["p"]
    is_touching = (pressure_of_reference[0] != 0) | (pressure_of_result[0] != 0)
    notes = []
    for letter in "pq":
        values_at_first_instant = difference_by_letter[letter][0]
        size_in_words = difference_in_words(
            values_at_first_instant, drawn.x, "x = {} a_ref", " %", is_touching
        )
        notes.append(f"{letter}: {size_in_words}")
    return notes


def _tractions_at(view: CycleView, instants: Sequence[int]) -> _DrawnTractions:
    """Tractions of both engines at the points that are drawn and at the k `instants` (indices), in
    their order, without repetitions. `view` holds the last cycles of both solutions, all points
    over a_ref, and the largest that is drawn.
    """
    is_drawn = np.abs(view.x) <= view.largest_x * 1.02
    instants_once = np.array(list(dict.fromkeys(instants)))
    grid = np.ix_(instants_once, np.flatnonzero(is_drawn))
    traction_pairs = {}
    for letter, (field, scale) in _traction_fields(view).items():
        reference_values = getattr(view.reference_cycle, field)[grid] / scale
        result_values = getattr(view.result_cycle, field)[grid] / scale
        traction_pairs[letter] = (reference_values, result_values)
    return _DrawnTractions(view.x[is_drawn], traction_pairs)


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
    panels = (traction_panel, _state_panel(view, width), difference_panel)
    return figure_with_texts("cycle", panels, table, traction_keys(view), n_columns=1)


def _state_panel(view: CycleView, width: float) -> Panel:
    """A panel with a strip along x for each engine, coloured by open, stick and slip at the instant
    that the page shows first. It has no axes, is `width` pixels wide, and its heights count
    downwards in pixels. `view` holds both engines.
    """
    marks: list[Mark] = []
    for strip_number, engine in enumerate(view.engines):
        marks += _strip_of_states(view, engine, strip_number)
    # Panel: name, both axes, marks, description, width and height
    return Panel(
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

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.
    """
    metric = view.comparison.metric("state")
    # The share of points that differ is that of the metric, weighted by lengths. Points crowd at
    # the edges, so that counting them would give a larger share.
    share_in_words = "" if metric.value is None else value_in_words(metric)
    # the table: of a long path evenly many instants, half a million states in all
    point_indices = np.flatnonzero(np.abs(view.x) <= view.largest_x)
    n_instants = min(len(view.time), max(_MOST_STATES // len(point_indices), 2))
    instant_indices = np.linspace(0, len(view.time) - 1, n_instants).round().astype(int)
    # with the legend of the four states; the arguments after `n_columns` fill the caption
    return figure_with_texts(
        "state_map",
        _maps_of_states(view, f"they differ: {share_in_words}".rstrip(": ")),
        _table_of_states(view, instant_indices, point_indices),
        STATE_KEYS,
        n_columns=3,
        share=share_in_words,
        written=len(instant_indices),
        instants=len(view.time),
        stretch=view.part_of_path,
    )


def _maps_of_states(view: CycleView, difference_title: str) -> list[Panel]:
    """Three panels over x and time: the contact states of the reference, those of the result, and
    where they differ. Each is a `Bitmap`, an image over the panel. `difference_title` is the title
    of the third.

    `view` holds the last cycles of both solutions, with states (k instants, n points) as codes 0 to
    3.
    """
    states_of_reference = view.reference_cycle.state
    states_of_result = view.result_cycle.state
    reference_engine, result_engine = view.engines
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
    # Panel: name, both axes, marks, description, width, height, title
    return [
        Panel(
            name,
            view.over_x(),
            view.over_time(),
            [Bitmap(values[pixels].astype(np.uint8), palette)],
            f"Map of states: {title}",
            340.0,
            320.0,
            title,
            time="y",
            css="pick",
        )
        for name, values, palette, title in maps
    ]


def _table_of_states(
    view: CycleView, instant_indices: NDArray[np.int_], point_indices: NDArray[np.int_]
) -> Table:
    """The contact states of both engines as columns, a row for each of these instants and points:
    time, x, and the state in the reference and in the result as a code. The headings explain the
    codes.

    `view` holds the last cycles of both solutions, with states (k instants, n points).
    `instant_indices` (k,) and `point_indices` (n,) are those of the rows.
    """
    grid = np.ix_(instant_indices, point_indices)
    # STATE_NAMES: code of a state -> its name, such as 1 -> "stick"
    codes = ", ".join(f"{int(state)} {state_name}" for state, state_name in STATE_NAMES.items())
    return {
        "time": np.repeat(view.result_cycle.time[instant_indices], len(point_indices)),
        "x": np.tile(view.result_cycle.x[point_indices], len(instant_indices)),
        f"state_reference ({codes})": view.reference_cycle.state[grid].ravel(),
        f"state_result ({codes})": view.result_cycle.state[grid].ravel(),
    }


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


class _Densities(NamedTuple):
    """The friction work per area w(x) of the last cycle by both engines, (n,) each.

    It is over A f² P_ref²/a_ref: A = 2/E* is the compliance of the materials, f the friction
    coefficient, P_ref and a_ref are load and half-width of the reference.
    """

    x: Array  # (n,) points over a_ref
    reference: Array
    result: Array


def dissipation_density(view: CycleView) -> Plate | None:
    """A figure of the friction work per area w(x) of the last cycle, both engines, and of their
    difference in per cent of the largest w of the reference. None where nothing is dissipated.

    `view` holds the last cycles of both solutions, with w (n,) at the points `x` over a_ref. The
    scale of w is A f^2 P_ref^2/a_ref: A = 2/E* the compliance of the materials, f the friction
    coefficient, P_ref and a_ref load and half-width of the reference.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend.
    """
    scales = view.scales
    scale_of_density = scales.dissipation / scales.half_width
    densities = _Densities(
        view.x,
        view.reference_cycle.dissipation_density / scale_of_density,
        view.result_cycle.dissipation_density / scale_of_density,
    )
    if not (np.any(densities.reference) or np.any(densities.result)):
        return None

    # ends of the zone that sticks through the whole cycle, over a_ref; NaN without one
    stick_edges = permanent_edges(view.comparison.reference) / scales.half_width
    known_density = np.where(np.isfinite(densities.result), densities.result, -np.inf)
    peak_index = int(np.nanargmax(known_density))
    scale_in_words = "(A f^2 P_ref^2/a_ref)"
    table = {
        "x": view.result_cycle.x,
        "x/a_ref": densities.x,
        f"w_reference/{scale_in_words}": densities.reference,
        f"w_result/{scale_in_words}": densities.result,
    }
    # the arguments after the legend fill the caption; `signed`: as text, to four digits
    return figure_with_texts(
        "dissipation_density",
        (
            _density_panel(view, densities, stick_edges, peak_index),
            _density_difference_panel(view, densities),
        ),
        table,
        (*view.keys, Key("d p", "difference")),
        stretch=view.part_of_path,
        peak=f"{densities.result[peak_index]:.4g}",
        place=signed(float(densities.x[peak_index])),
        stick=_ends_in_words(stick_edges),
    )


def _density_panel(
    view: CycleView, densities: _Densities, stick_edges: Array, peak_index: int
) -> Panel:
    """A panel of the friction work per area over x by both engines. Upright lines mark the ends
    `stick_edges` (2,) of the zone that always sticks (over a_ref, NaN without one). A dot marks the
    largest value of the result, at the point of index `peak_index`.

    `densities` are over A f² P_ref²/a_ref, the scale of the axis. `view` holds the axis of x.
    """
    x = densities.x
    marks: list[Mark] = [
        Rule(float(edge), "stick-line", is_upright=True)
        for edge in stick_edges
        if np.isfinite(edge)
    ]
    # the legend entries `keys` have class and name of both engines
    for density, key in zip((densities.reference, densities.result), view.keys, strict=True):
        marks.append(Curve(x, density, key.css, key.text))
    marks.append(Dot(float(x[peak_index]), float(densities.result[peak_index]), "event"))
    return Panel(
        "work",
        view.over_x(),
        Axis(
            *axis_limits(densities.reference, densities.result, with_zero=True),
            "w / (A f² P_ref²/a_ref)",
        ),
        marks,
        "Dissipation density over x",
        css="pick",
    )


def _density_difference_panel(view: CycleView, densities: _Densities) -> Panel:
    """A panel of the difference of the friction work per area, result minus reference, over x. It
    is in per cent of the largest value of the reference, or of its unit where the reference
    dissipates nothing. A note states its size in words.

    `densities` are those of both engines at the points x (n,). `view` holds the axis of x.
    """
    x = densities.x
    largest_density = float(np.nanmax(np.abs(densities.reference), initial=0.0)) or 1.0
    difference = 100 * (densities.result - densities.reference) / largest_density
    has_dissipation = (densities.reference != 0) | (densities.result != 0)
    is_drawn = np.abs(x) <= view.largest_x
    note = difference_in_words(difference, x, "x = {} a_ref", " %", is_drawn & has_dissipation)
    # `ZERO` is a line at zero
    return Panel(
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


def _ends_in_words(ends: Array) -> str:
    """Both ends of the permanent stick zone over a_ref; nothing where there is none."""
    left_end, right_end = ends
    if not np.isfinite(ends).all():
        return ""
    if left_end == -right_end:
        return f"±{right_end:.4g}"
    return minus(f"{left_end:.4g} and {right_end:.4g}")
