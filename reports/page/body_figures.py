"""Figures of the scene: both bodies to scale, and the residuals of a fitted profile."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import (
    Arrow,
    Axis,
    Band,
    Curve,
    Dot,
    Frame,
    Mark,
    Note,
    Panel,
    Plate,
    Rule,
    Scale,
    Segments,
    axis_limits,
    figure_with_texts,
)
from reports.charts.templating import Table
from reports.comparison.words import bodies_in_words, bulk_and_tilt_in_words
from reports.profile_fit import profile_fit_of
from reports.units import load_unit, number, units
from scenes import Cylinder, HalfPlane, Scene, Shape, ShoulderedPad, TShape, sampled_times
from scenes.array_types import Array
from scenes.bodies import face_of
from scenes.profiles import Fitted

# Half the width of a half-plane as drawn: over that of the contact, and of the body that it faces.
_HALF_WIDTHS_OF_CONTACT_SHOWN = 6.0

_HALF_WIDTHS_OF_BODY_SHOWN = 1.3

# Of the sketch [pixels]: its width, its largest height, room above the bodies and on other sides.
_SKETCH_WIDTH = 440.0

_LARGEST_SKETCH_HEIGHT = 310.0

_ROOM_ABOVE = 76.0

_ROOM_AT_SIDES = 30.0

_FACE_POINTS = 181  # of an outline

# Rows of a measured profile that are drawn.
_MOST_DOTS = 400


def sketch(scene: Scene, half_width: float) -> Plate:
    """A figure of both bodies to scale, with their supports, their loads and the contact.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.

    Parameters
    ----------
    half_width
        half-width of the contact, drawn to scale [length]
    """
    _, unit_of_length, _ = units(scene)
    # by body: (n, 2) x, and y upwards from the contact plane [length]
    outlines = {name: outline(scene, name, half_width) for name in ("lower", "upper")}
    table: Table = {
        "body": [name for name in outlines for _ in outlines[name]],
        f"x [{unit_of_length}]": np.concatenate([points[:, 0] for points in outlines.values()]),
        f"y [{unit_of_length}]": np.concatenate([points[:, 1] for points in outlines.values()]),
    }
    shapes = (scene.bodies.lower, scene.bodies.upper)
    # The arguments after `n_columns` fill the caption: whether a half-plane is cut off, width of
    # the contact, ranges of P and Q in words, what acts beside P and Q, units. `number`: as text,
    # to six digits
    return figure_with_texts(
        "bodies",
        [_panel_of_bodies(scene, outlines, half_width)],
        table,
        n_columns=1,
        cut=any(isinstance(shape, HalfPlane) for shape in shapes),
        width=number(2 * half_width),
        length=unit_of_length,
        normal=_range_in_words(_normal_loads(scene)),
        tangential=_range_in_words(_tangential_loads(scene)),
        load=load_unit(scene),
        beside=bulk_and_tilt_in_words(scene),
        alt=bodies_in_words(scene),
    )


def _panel_of_bodies(scene: Scene, outlines: dict[str, Array], half_width: float) -> Panel:
    """A panel of both bodies to scale, with supports, names, arrows of the loads, and a line for
    the contact of this half-width [length].

    Marks are placed in pixels, since supports and arrows have no size in the scene. `outlines`:
    "lower" or "upper" -> outline of the body, (n, 2) x and y [length], y upwards from the contact
    plane.
    """
    frame = _frame_of_sketch(outlines)  # scales from lengths to pixels
    marks: list[Mark] = []
    for name, points in outlines.items():
        shape = getattr(scene.bodies, name)
        marks += _marks_of_body(frame, points, shape, name)
        outward_sign = 1.0 if name == "lower" else -1.0
        marks += _marks_of_supports(frame, shape, points, outward_sign)
        y_of_label = 16.0 if name == "upper" else frame.height - 6
        marks.append(Note(6.0, y_of_label, _label_of_body(scene, name), "word"))
    x_of_contact = frame.x.pixels_of([-half_width, half_width])
    y_of_contact = float(frame.y.pixels_of(0.0))
    marks.append(Curve(x_of_contact, [y_of_contact, y_of_contact], "contact-line"))
    marks += _marks_of_loads(frame, scene, outlines)
    return Panel(
        "bodies",
        Axis(0.0, frame.width, ""),
        Axis(frame.height, 0.0, ""),
        marks,
        bodies_in_words(scene),
        frame.width,
        frame.height,
        without_axes=True,
        room=(0.0, 0.0, 0.0, 0.0),
    )


def fit_residuals(scene: Scene, half_width: float) -> Plate | None:
    """A figure of a profile fitted to measured rows, in two panels: the trace, levelled by the fit,
    with the fitted curve; and the residuals, row minus curve, with a band of ± twice the noise and
    lines at ± `half_width`. None for a profile that is not fitted.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.

    Parameters
    ----------
    half_width
        half-width of the largest contact [length]
    """
    # the measured rows, the standard deviation of their heights (`noise`), and the root mean square
    # of row minus curve (`residual`)
    fit_record = profile_fit_of(scene)
    if fit_record is None:
        return None
    _, unit_of_length, _ = units(scene)
    # the rows, and the fitted curve at each; `spikes` are rows that the fit left out
    trace = _trace_of(scene, fit_record)
    panels = (
        _panel_of_trace(trace, unit_of_length),
        _panel_of_residuals(trace, fit_record.noise, half_width, unit_of_length),
    )
    table = {
        f"x [{unit_of_length}]": trace.x,
        f"row, levelled [{unit_of_length}]": trace.levelled_height,
        f"fit [{unit_of_length}]": trace.fitted_height,
        f"row - fit [{unit_of_length}]": trace.residuals,
        "fitted": trace.is_fitted.astype(float),
    }
    # The arguments after `n_columns` fill the caption; `every`: one in so many fitted rows is
    # drawn.
    return figure_with_texts(
        "profile_fit",
        panels,
        table,
        n_columns=1,
        spikes=len(trace.spikes),
        rows=trace.is_fitted.sum(),
        residual=f"{fit_record.residual:.3g}",
        noise=f"{fit_record.noise:.3g}",
        length=unit_of_length,
        every=trace.drawn_rows[1] - trace.drawn_rows[0],
    )


class _Trace(NamedTuple):
    """The trace of a measured profile: its n rows, and the curve that was fitted to them.

    Attributes
    ----------
    x
        (n,) from the middle of the profile [length]
    fitted_height, residuals
        (n,) height of the curve at the rows, and row minus curve [length]
    is_fitted
        (n,) whether the row was fitted
    drawn_rows
        indices of the fitted rows that are drawn, evenly chosen where there are many
    spikes
        indices of the rows that were left out as spikes
    """

    x: Array
    fitted_height: Array
    residuals: Array
    is_fitted: NDArray[np.bool_]
    drawn_rows: NDArray[np.intp]
    spikes: NDArray[np.int64]

    @property
    def levelled_height(self) -> Array:
        """(n,) height of the rows, with tilt and offset of the trace taken out [length]."""
        return self.fitted_height + self.residuals

    def x_axis(self, unit_of_length: str) -> Axis:
        """The axis of both panels: all fitted rows."""
        ends = axis_limits(self.x[self.is_fitted], margin=0.02)
        return Axis(*ends, f"x from the middle  [{unit_of_length}]")


def _trace_of(scene: Scene, fit_record: Fitted) -> _Trace:
    """The rows of a measured profile and the height of the fitted curve at each. Of the fitted rows
    at most 400 are drawn, evenly chosen.

    `fit_record` holds the rows [x, height] (n, 2), x of the middle (`centre`), indices of the rows
    that were fitted, and the numbers, from 1 on, of those left out as spikes.
    """
    x = fit_record.rows.values[:, 0] - fit_record.centre
    is_fitted = np.isin(np.arange(len(x)), fit_record.used_rows())
    stride = -(-int(is_fitted.sum()) // _MOST_DOTS)
    return _Trace(
        x=x,
        fitted_height=scene.profile.height(x),
        residuals=fit_record.residuals(scene.profile.height),
        is_fitted=is_fitted,
        drawn_rows=np.flatnonzero(is_fitted)[::stride],
        spikes=np.array(fit_record.spikes, dtype=np.int64) - 1,
    )


def _panel_of_trace(trace: _Trace, unit_of_length: str) -> Panel:
    """A panel of a measured profile: the height of its rows, with tilt and offset taken out, and
    the curve that was fitted to them.

    `trace` holds x (n,), height of the rows and of the curve (n,) [length], which rows were fitted
    (n,), indices of those drawn, and of those left out as spikes.
    """
    height = trace.levelled_height
    order_of_x = np.argsort(trace.x)
    marks: list[Mark] = [
        Dot(float(trace.x[row]), float(height[row]), "p0", 2.2, f"row {row + 1}")
        for row in trace.drawn_rows
    ]
    marks += [
        Dot(float(trace.x[row]), float(height[row]), "p3", 4.0, f"row {row + 1}: left out")
        for row in trace.spikes
    ]
    marks.append(Curve(trace.x[order_of_x], trace.fitted_height[order_of_x], "line-1", "fit"))
    rows_in_limits = np.union1d(np.flatnonzero(trace.is_fitted), trace.spikes)
    return Panel(
        "profile-trace",
        trace.x_axis(unit_of_length),
        Axis(
            *axis_limits(height[rows_in_limits], trace.fitted_height[trace.is_fitted]),
            f"h, levelled  [{unit_of_length}]",
        ),
        marks,
        "Trace and fit",
        height=260.0,
    )


def _panel_of_residuals(
    trace: _Trace, noise: float, half_width: float, unit_of_length: str
) -> Panel:
    """A panel of the residuals of a fitted profile, height of the row minus fitted curve, with a
    band of ± twice the noise and lines at the edges of the largest contact.

    `Rule` is a line across the panel and `Band` the area between two curves.

    Parameters
    ----------
    trace
        x (n,) and residuals (n,) of the rows [length], which were fitted (n,), and indices of those
        drawn
    noise
        standard deviation of the height of a row [length]
    half_width
        half-width of the largest contact [length]
    """
    fitted_x = trace.x[trace.is_fitted]
    twice_the_noise = np.full(len(fitted_x), 2 * noise)
    marks: list[Mark] = [
        Band(fitted_x, -twice_the_noise, twice_the_noise, "band pale-stick"),
        Rule(0.0, "zero"),
        Rule(-half_width, "cycle-line", is_upright=True),
        Rule(half_width, "cycle-line", is_upright=True),
    ]
    for row in trace.drawn_rows:
        label = f"x = {trace.x[row]:.4g}, {trace.residuals[row]:.3g} {unit_of_length}"
        marks.append(Dot(float(trace.x[row]), float(trace.residuals[row]), "p0", 2.2, label))
    largest_residual = float(np.abs(trace.residuals[trace.is_fitted]).max())
    axis_end = 1.1 * max(largest_residual, 2.2 * noise)
    return Panel(
        "profile-fit",
        trace.x_axis(unit_of_length),
        Axis(-axis_end, axis_end, f"row − fit  [{unit_of_length}]"),
        marks,
        "Residuals of the fit",
        height=260.0,
    )


def _frame_of_sketch(outlines: dict[str, Array]) -> Frame:
    """Scales of the sketch of both bodies, from lengths to pixels: the same in both directions.
    Room is left above for the arrows of the loads, and on the other sides for supports.

    `outlines` are the outlines of the bodies, (n, 2) each: x, y [length]. The sketch is 440 pixels
    wide and at most 310 high.
    """
    points = np.concatenate(list(outlines.values()))
    left_x, least_y = points.min(axis=0)
    right_x, largest_y = points.max(axis=0)
    # lengths for which a pixel stands where the width, or the height, fills the sketch; room for
    # arrows and supports is left free
    # _SKETCH_WIDTH, ...: size of the sketch and room in it [pixels]
    length_per_pixel_by_width = (right_x - left_x) / (_SKETCH_WIDTH - 2 * _ROOM_AT_SIDES)
    length_per_pixel_by_height = (largest_y - least_y) / (
        _LARGEST_SKETCH_HEIGHT - _ROOM_ABOVE - _ROOM_AT_SIDES
    )
    length_per_pixel = max(length_per_pixel_by_width, length_per_pixel_by_height)
    height = float((largest_y - least_y) / length_per_pixel + _ROOM_ABOVE + _ROOM_AT_SIDES)
    middle_x = (left_x + right_x) / 2
    half_width_of_drawing = (_SKETCH_WIDTH / 2 - _ROOM_AT_SIDES) * length_per_pixel
    # a scale: first and last value [length], and where they lie [pixels, y downwards]
    x_scale = Scale(
        float(middle_x - half_width_of_drawing),
        float(middle_x + half_width_of_drawing),
        _ROOM_AT_SIDES,
        _SKETCH_WIDTH - _ROOM_AT_SIDES,
    )
    y_scale = Scale(float(least_y), float(largest_y), height - _ROOM_AT_SIDES, _ROOM_ABOVE)
    return Frame(x_scale, y_scale, _SKETCH_WIDTH, height)


def outline(scene: Scene, name: str, half_width: float) -> Array:
    """Outline of a body, (n, 2): x, and y upwards from the contact plane [length]. It goes along
    181 points of the face from its left end to the right, then round the base; of a cylinder it is
    the face alone.

    A half-plane is drawn as a rectangle, 1.3 times as wide as the body that it faces. Where both
    are half-planes it is 6 times as wide as the contact, whose half-width is `half_width`. `name`
    is "lower" or "upper".
    """
    shape = getattr(scene.bodies, name)
    facing_shape = getattr(scene.bodies, "upper" if name == "lower" else "lower")
    outward_sign = 1.0 if name == "lower" else -1.0
    drawn_half_width = shape.face_half_width
    body_height = getattr(shape, "height", 0.0)
    if isinstance(shape, HalfPlane):
        drawn_half_width = _HALF_WIDTHS_OF_BODY_SHOWN * facing_shape.face_half_width
        if isinstance(facing_shape, HalfPlane):
            drawn_half_width = _HALF_WIDTHS_OF_CONTACT_SHOWN * half_width
        body_height = 0.5 * drawn_half_width
    # Finer towards the ends, where an arc is steep.
    x = drawn_half_width * np.sin(np.linspace(-np.pi / 2, np.pi / 2, _FACE_POINTS))
    # `depth`: of the face below the plane of first contact, into the body [length]
    face = np.column_stack([x, -outward_sign * face_of(shape, scene.profile).depth(x)])
    if isinstance(shape, Cylinder):
        return face
    # x and depth of the corners beside and below the face
    right_side = [(drawn_half_width, body_height)]
    if isinstance(shape, TShape | ShoulderedPad):
        # at the depth of the step the width changes: below a flange, or at a shoulder
        half_width_below_step = shape.step.half_width
        right_side = [
            (drawn_half_width, shape.step.depth),
            (half_width_below_step, shape.step.depth),
            (half_width_below_step, body_height),
        ]
    left_side = [(-corner_x, corner_depth) for corner_x, corner_depth in reversed(right_side)]
    return np.vstack([face, np.array(right_side + left_side) * [1.0, -outward_sign]])


def _marks_of_body(frame: Frame, points: Array, shape: Shape, name: str) -> Iterator[Mark]:
    """What is drawn for a body: its filled area and its outline. A half-plane has a solid line
    along its face alone, and a dotted line where the drawing cuts it off.

    Parameters
    ----------
    frame
        the scales of the sketch, from lengths to pixels
    shape
        the body's shape: a half-plane or a finite body
    points
        (n, 2) outline, along 181 points from the left end of the face to the right one and round
        the base [length]
    name
        "lower" or "upper"
    """
    x_in_pixels = frame.x.pixels_of(points[:, 0])
    y_in_pixels = frame.y.pixels_of(points[:, 1])
    yield Curve(x_in_pixels, y_in_pixels, f"body {name}", is_closed=True)
    if not isinstance(shape, HalfPlane):
        yield Curve(x_in_pixels, y_in_pixels, "body-line", is_closed=True)
        return
    # from the right end of the face round the base to the left end
    points_of_cut = [_FACE_POINTS - 1, _FACE_POINTS, _FACE_POINTS + 1, 0]
    yield Curve(x_in_pixels[:_FACE_POINTS], y_in_pixels[:_FACE_POINTS], "body-line")
    yield Curve(x_in_pixels[points_of_cut], y_in_pixels[points_of_cut], "cut-line")


def _marks_of_supports(
    frame: Frame, shape: Shape, points: Array, outward_sign: float
) -> Iterator[Mark]:
    """What is drawn for the supports of a body: a hatched rigid plane along its base, and along its
    sides where they are guided, with rollers between where it may slide. Nothing for a half-plane.

    Parameters
    ----------
    frame
        the scales of the sketch, from lengths to pixels
    shape
        the body's shape, with its supports: `base` fixed or on rollers, `sides` free or guided
    points
        (n, 2) outline of the body [length]
    outward_sign
        1 for the lower body, -1 for the upper one
    """
    if isinstance(shape, HalfPlane):
        return
    y_of_face = float(frame.y.pixels_of(points[0, 1]))  # at its left end
    # the base: points farthest from the face
    farthest_point = np.argmax(-outward_sign * points[:, 1])
    is_at_base = points[:, 1] == points[farthest_point, 1]
    half_width_of_base = float(np.abs(points[is_at_base, 0]).max())
    left_x, right_x = frame.x.pixels_of([-half_width_of_base, half_width_of_base]).tolist()
    y_of_base = float(frame.y.pixels_of(points[farthest_point, 1]))
    base_has_rollers = getattr(shape, "base", "") == "rollers"
    # ends of the plane, direction away from the body, whether with rollers; in pixels, y downwards
    yield from _marks_of_plane(
        (left_x, y_of_base), (right_x, y_of_base), (0.0, outward_sign), base_has_rollers
    )
    if getattr(shape, "sides", "") == "guided":
        yield from _marks_of_plane(
            (left_x, y_of_base), (left_x, y_of_face), (-1.0, 0.0), has_rollers=True
        )
        yield from _marks_of_plane(
            (right_x, y_of_base), (right_x, y_of_face), (1.0, 0.0), has_rollers=True
        )


def _marks_of_plane(
    start: tuple[float, float],
    end: tuple[float, float],
    outward: tuple[float, float],
    has_rollers: bool,
) -> Iterator[Mark]:
    """What is drawn for a rigid plane along a side of a body: a line with hatches, and rollers
    between body and line where `has_rollers`.

    `Segments` are straight lines.

    Parameters
    ----------
    start, end
        ends of the side of the body [pixels]
    outward
        unit vector from the body towards the plane
    has_rollers
        whether the body may slide along the plane
    """
    roller_radius = 10.0 / 3
    hatch_length = 7.0  # along the line, and across it
    # the line lies on the side of the body, or beyond the rollers
    start_of_line = np.array(start)
    end_of_line = np.array(end)
    outward_normal = np.array(outward)
    if has_rollers:
        fractions_of_side = np.linspace(0.08, 0.92, 7)[:, None]
        points_on_side = start_of_line + fractions_of_side * (end_of_line - start_of_line)
        centres = points_on_side + outward_normal * roller_radius
        for x, y in centres:
            yield Dot(float(x), float(y), "roller", roller_radius)
        start_of_line = start_of_line + outward_normal * 2 * roller_radius
        end_of_line = end_of_line + outward_normal * 2 * roller_radius
    length_of_line = np.hypot(*(end_of_line - start_of_line))
    direction_of_line = (end_of_line - start_of_line) / length_of_line
    n_hatches = max(int(length_of_line / 8), 4)
    fractions_of_line = np.linspace(0, 1, n_hatches)[:, None]
    starts_of_hatches = start_of_line + fractions_of_line * (end_of_line - start_of_line)
    ends_of_hatches = starts_of_hatches + hatch_length * (outward_normal - direction_of_line)
    yield Curve([start_of_line[0], end_of_line[0]], [start_of_line[1], end_of_line[1]], "wall")
    yield Segments(np.stack([starts_of_hatches, ends_of_hatches], axis=1), "curve hatch")


def _label_of_body(scene: Scene, name: str) -> str:
    """The text beside a body in the sketch: its kind, its sizes, Young's modulus E and Poisson's
    ratio nu, with units. `name` is "lower" or "upper".
    """
    shape = getattr(scene.bodies, name)
    material = getattr(scene.material, name)
    _, unit_of_length, unit_of_stress = units(scene)
    sizes_in_words = ""
    if isinstance(shape, Cylinder):
        # `number`: as text, to six digits
        sizes_in_words = f" R = {number(shape.radius)} {unit_of_length}"
    elif not isinstance(shape, HalfPlane):
        sizes_in_words = f" {number(shape.width)} × {number(shape.height)} {unit_of_length}"
    young_modulus = number(material.young_modulus)
    poisson_ratio = number(material.poisson_ratio)
    material_in_words = f"E = {young_modulus} {unit_of_stress}, ν = {poisson_ratio}"
    return f"{name}: {shape.kind.replace('_', '-')}{sizes_in_words}, {material_in_words}"


def _marks_of_loads(frame: Frame, scene: Scene, outlines: dict[str, Array]) -> Iterator[Mark]:
    """What is drawn for the loads: arrows of P and Q at the top of the upper body, a turning arrow
    for its tilt or moment, and arrows of bulk stress at both ends of a body that has one. A line
    shows where P acts, if the scene states it.

    `Note` is a text.

    Parameters
    ----------
    frame
        scales of the sketch, from lengths to pixels
    outlines
        (n, 2) outline of each body, by "lower" and "upper" [length]
    """
    stated_load = scene.load
    y_of_top = float(frame.y.pixels_of(outlines["upper"][:, 1].max())) - 8  # [pixels, downwards]
    y_of_contact = float(frame.y.pixels_of(0.0))
    line_of_action = stated_load.line_of_action
    x_of_action = frame.x.pixels_of(line_of_action.x if line_of_action else 0.0)
    # within the drawing; the caption says where the line of action is
    x_of_arrow = float(np.clip(x_of_action, 80.0, frame.width - 80.0))
    if line_of_action is not None:
        yield Curve(
            [x_of_arrow, x_of_arrow],
            [y_of_contact - 0.3 * (y_of_contact - y_of_top), y_of_contact],
            "cycle-line",
        )
    yield Arrow((x_of_arrow, y_of_top - 42), (x_of_arrow, y_of_top))
    yield Note(x_of_arrow - 9, y_of_top - 28, "P", "load", "end")
    if np.any(_tangential_loads(scene) != 0):
        yield Arrow((x_of_arrow + 8, y_of_top - 8), (x_of_arrow + 58, y_of_top - 8))
        yield Note(x_of_arrow + 63, y_of_top - 3, "Q", "load")
    # A positive tilt opens the gap at x > 0; a positive moment presses there, and so turns the
    # other way.
    if stated_load.tilt is not None:
        yield from _turning_arrow((x_of_arrow - 48.0, y_of_top - 17.0), 1.0, "α")
    elif stated_load.moment is not None:
        yield from _turning_arrow((x_of_arrow - 48.0, y_of_top - 17.0), -1.0, "M")
    for name, stress in (
        ("lower", stated_load.bulk_stress_lower),
        ("upper", stated_load.bulk_stress_upper),
    ):
        if stress is not None:
            yield from _bulk_arrows(frame, outlines[name])


def _turning_arrow(middle: tuple[float, float], turning_sign: float, letter: str) -> Iterator[Mark]:
    """An arrow along an arc about `middle` [pixels], with its letter there; `turning_sign` is 1
    counter-clockwise, -1 clockwise.
    """
    x, y = middle
    angle = np.linspace(-0.2, 1.2, 29) * np.pi
    arc_x = x + turning_sign * 18 * np.cos(angle)
    arc_y = y - 18 * np.sin(angle)
    yield Curve(arc_x[:-3], arc_y[:-3], "arrow")
    yield Arrow((arc_x[-8], arc_y[-8]), (arc_x[-1], arc_y[-1]))
    yield Note(x, y + 5, letter, "load", "middle")


def _bulk_arrows(frame: Frame, points: Array) -> Iterator[Mark]:
    """Arrows of bulk stress away from both ends of a body, midway between face and base. `points`
    (n, 2) are its outline, first along the face from left to right [length].
    """
    left_x, right_x = frame.x.pixels_of(points[[0, _FACE_POINTS - 1], 0]).tolist()
    middle_y = float(np.mean(frame.y.pixels_of(points[[0, -1], 1])))
    for end_x, outward_sign in ((left_x, -1.0), (right_x, 1.0)):
        yield Arrow((end_x + 3 * outward_sign, middle_y), (end_x + 23 * outward_sign, middle_y))
        yield Note(end_x + 13 * outward_sign, middle_y - 9, "σ", "load", "middle")


def _normal_loads(scene: Scene) -> Array:
    """P all along the path."""
    normal_load, _ = scene.load.path().at(_sample_times(scene))
    return np.asarray(normal_load)


def _tangential_loads(scene: Scene) -> Array:
    """Q all along the path."""
    _, tangential_load = scene.load.path().at(_sample_times(scene))
    return np.asarray(tangential_load)


def _sample_times(scene: Scene) -> Array:
    """Many instants of initial loading and first cycle."""
    segments = scene.load.path().segments(1)
    return np.concatenate([sampled_times(segment, 181) for segment in segments])


def _range_in_words(loads: Array) -> str:
    """Least and largest of loads in words: "from 60 to 120", or "= 90" where both are equal."""
    least_load = number(float(f"{loads.min():.4g}"))
    largest_load = number(float(f"{loads.max():.4g}"))
    return (
        f"= {largest_load}"
        if least_load == largest_load
        else f"from {least_load} to {largest_load}"
    )
