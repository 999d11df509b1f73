"""The sketch of a scene: both bodies to scale, what holds them, the loads; a measured profile beside its fit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Arrow, Axis, Band, Curve, Dot, Frame, Mark, Note, Rule, Segments
from reports.charts.plate import Panel, Plate, worded
from reports.charts.scale import Scale, limits
from reports.charts.table import Table
from reports.comparison.words import bodies_in_words, bulk_and_tilt, sentence
from reports.profile_fit import fit_of
from reports.units import load_unit, number, units
from scenes import Cylinder, HalfPlane, Scene, Shape, sampled
from scenes.bodies import face_of

Array = NDArray[np.float64]

# Half the width of a half-plane as drawn, over a or over the half-width of the body that it faces.
_SHOWN_OF_CONTACT, _SHOWN_OF_BODY = 6.0, 1.3
# Share of the sketch that a body takes at least where its label stands inside.
_WIDE_ENOUGH = 0.62
# What the longest line of a label in four lines needs [units of the drawing].
_LETTERS = 122.0
_WIDTH, _MOST, _ROOM, _SIDE = 440.0, 310.0, 62.0, 26.0
# Rows of a measured profile that are drawn.
_MOST_DOTS = 400


def sketch(scene: Scene, half_width: float) -> Plate:
    """Both bodies to scale with supports, loads and the place of the contact.

    Parameters
    ----------
    half_width : of the contact, drawn to scale [length]
    """
    length = units(scene)[1]
    outlines = {name: outline(scene, name, half_width) for name in ("lower", "upper")}
    frame = _frame(outlines)
    marks: list[Mark] = []
    for name, side in (("lower", 1.0), ("upper", -1.0)):
        shape = getattr(scene.bodies, name)
        marks += [*_body(frame, outlines[name], shape, name), *_supports(frame, shape, outlines[name], side)]
    level = float(frame.y.place(0.0))
    marks.append(Curve(frame.x.place([-half_width, half_width]), [level, level], "contact-line"))
    marks += [note for name in outlines for note in _label(frame, scene, name, outlines[name])]
    marks += _loads(frame, scene, outlines)
    columns: Table = {
        "body": [name for name in outlines for _ in outlines[name]],
        f"x [{length}]": np.concatenate([points[:, 0] for points in outlines.values()]),
        f"y [{length}]": np.concatenate([points[:, 1] for points in outlines.values()]),
    }
    alt = bodies_in_words(scene)
    # Places of the marks are those of the drawing: supports and arrows have no size in the scene.
    axes = Axis(0.0, frame.width, ""), Axis(frame.height, 0.0, "")
    panel = Panel("bodies", *axes, marks, alt, frame.width, frame.height, bare=True, room=(0.0, 0.0, 0.0, 0.0))
    beside = bulk_and_tilt(scene)
    return worded(
        "bodies",
        [panel],
        columns,
        columns=1,
        cut=any(isinstance(body, HalfPlane) for body in (scene.bodies.lower, scene.bodies.upper)),
        width=number(2 * half_width),
        length=length,
        normal=_range(scene, 0),
        tangential=_range(scene, 1),
        load=load_unit(scene),
        beside=sentence(beside.removeprefix("; ")) if beside else "",
        alt=alt,
    )


def fit_residuals(scene: Scene, half_width: float) -> Plate | None:
    """Rows minus the curve fitted to them, beside twice their noise; None of a profile that is not fitted.

    Parameters
    ----------
    half_width : of the largest contact [length]
    """
    fitted = fit_of(scene)
    if fitted is None:
        return None
    length = units(scene)[1]
    x = fitted.rows.values[:, 0] - fitted.centre
    rest = fitted.rows.values[:, 1] - fitted.offset - scene.profile.height(x)
    used = np.abs(x) <= np.sort(np.abs(x))[len(x) - fitted.left_out - 1]
    shown = np.flatnonzero(used)[:: -(-int(used.sum()) // _MOST_DOTS)]
    most = 1.1 * max(float(np.abs(rest[used]).max()), 2.2 * fitted.noise)
    across = Axis(*limits(x[used], margin=0.02), f"x from the middle  [{length}]")
    wide = np.full(int(used.sum()), 2 * fitted.noise)
    marks: list[Mark] = [Band(x[used], -wide, wide, "band pale-stick")]
    marks += [Rule(0.0, "zero"), *(Rule(side * half_width, "cycle-line", upright=True) for side in (-1, 1))]
    marks += [Dot(float(x[k]), float(rest[k]), "p0", 2.2, f"x = {x[k]:.4g}, {rest[k]:.3g} {length}") for k in shown]
    up = Axis(-most, most, f"row − fit  [{length}]")
    return worded(
        "profile_fit",
        [Panel("profile-fit", across, up, marks, "Residuals of the fit", height=260.0)],
        {f"x [{length}]": x, f"row - fit [{length}]": rest, "fitted": used.astype(float)},
        columns=1,
        rows=used.sum(),
        residual=f"{fitted.residual:.3g}",
        noise=f"{fitted.noise:.3g}",
        length=length,
        every=shown[1] - shown[0],
    )


def _frame(outlines: dict[str, Array]) -> Frame:
    """Both bodies with one scale in both directions, room above for the loads and all round for supports."""
    points = np.concatenate(list(outlines.values()))
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    unit = max((right - left) / (_WIDTH - 2 * _SIDE), (high - low) / (_MOST - _ROOM - _SIDE))
    height = (high - low) / unit + _ROOM + _SIDE
    middle, half = (left + right) / 2, (_WIDTH / 2 - _SIDE) * unit
    across = Scale(float(middle - half), float(middle + half), _SIDE, _WIDTH - _SIDE)
    return Frame(across, Scale(float(low), float(high), float(height - _SIDE), _ROOM), _WIDTH, float(height))


def outline(scene: Scene, name: str, half_width: float) -> Array:
    """(n, 2) outline of a body in the common frame, from the left end of its face to the right one and round its base [length].

    A half-plane is drawn as a piece of itself: as wide as suits the other body, or the contact.
    """
    shape, other = getattr(scene.bodies, name), getattr(scene.bodies, "upper" if name == "lower" else "lower")
    side = 1.0 if name == "lower" else -1.0
    width = shape.face_half_width
    if isinstance(shape, HalfPlane):
        width = _SHOWN_OF_CONTACT * half_width if isinstance(other, HalfPlane) else _SHOWN_OF_BODY * other.face_half_width
    # Finer towards the ends, where an arc is steep.
    x = width * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 181))
    face = np.column_stack([x, -side * face_of(shape, scene.profile).depth(x)])
    height = 0.5 * width if isinstance(shape, HalfPlane) else getattr(shape, "height", 0.0)
    corners = np.array([[width, -side * height], [-width, -side * height]])
    return face if isinstance(shape, Cylinder) else np.vstack([face, corners])


def _body(frame: Frame, points: Array, shape: Shape, name: str) -> Iterator[Mark]:
    """A filled body; a half-plane has a line along its face alone, for it goes on everywhere else."""
    x, y = frame.x.place(points[:, 0]), frame.y.place(points[:, 1])
    yield Curve(x, y, f"body {name}", closed=True)
    if not isinstance(shape, HalfPlane):
        yield Curve(x, y, "body-line", closed=True)
        return
    corners = [180, 181, 182, 0]
    yield Curve(x[:181], y[:181], "body-line")
    yield Curve(x[corners], y[corners], "cut-line")


def _supports(frame: Frame, shape: Shape, points: Array, side: float) -> Iterator[Mark]:
    """Hatching where a body is fixed, rollers where it is guided; what holds the upper body moves, and has no hatching."""
    if isinstance(shape, HalfPlane):
        return
    half = shape.face_half_width
    left, right = (float(v) for v in frame.x.place([-half, half]))
    base = float(frame.y.place(points[np.argmax(-side * points[:, 1]), 1]))
    rollers, guided = (getattr(shape, key, "") == word for key, word in (("base", "rollers"), ("sides", "guided")))
    yield from _wall((left, base), (right, base), (0.0, side), rollers=rollers, hatched=side > 0)
    if guided:
        top = float(frame.y.place(points[0, 1]))
        for x, outward in ((left, -1.0), (right, 1.0)):
            yield from _wall((x, base), (x, top), (outward, 0.0), rollers=True, hatched=side > 0)


def _wall(
    start: tuple[float, float], end: tuple[float, float], outward: tuple[float, float], *, rollers: bool, hatched: bool
) -> Iterator[Mark]:
    """A rigid plane along start-end, rollers between it and the body where asked; hatched where it is at rest."""
    first, last, normal, size = np.array(start), np.array(end), np.array(outward), 10.0
    if rollers:
        for share in np.linspace(0.08, 0.92, 7):
            x, y = first + share * (last - first) + normal * size / 3
            yield Dot(float(x), float(y), "roller", size / 3)
        first, last = first + normal * 2 * size / 3, last + normal * 2 * size / 3
    yield Curve([first[0], last[0]], [first[1], last[1]], "wall" if hatched else "wall moving")
    if hatched:
        along = (last - first) / np.hypot(*(last - first))
        feet = first + np.linspace(0, 1, max(int(np.hypot(*(last - first)) / 8), 4))[:, None] * (last - first)
        yield Segments(np.stack([feet, feet + 0.7 * size * (normal - along)], axis=1), "curve hatch")


def _label(frame: Frame, scene: Scene, name: str, points: Array) -> Iterator[Mark]:
    """Kind, sizes and material in the middle of a body, or beside one that is too narrow for them."""
    shape, material = getattr(scene.bodies, name), getattr(scene.material, name)
    _, length, stress = units(scene)
    size = ""
    if isinstance(shape, Cylinder):
        size = f", R = {number(shape.radius)} {length}"
    elif not isinstance(shape, HalfPlane):
        size = f", {number(shape.width)} × {number(shape.height)} {length}"
    lines = [f"{name}: {shape.kind.replace('_', '-')}{size}", f"E = {number(material.young_modulus)} {stress},"]
    lines.append(f"ν = {number(material.poisson_ratio)}")
    x, y = frame.x.place(points[:, 0]), frame.y.place(points[:, 1])
    wide, tall = float(np.ptp(x)), float(np.ptp(y))
    level = float(y.min()) + tall * (0.58 if name == "lower" else 0.42)
    place, inside = float(x.min()) + wide / 2, True
    if wide > _WIDE_ENOUGH * frame.width:
        lines = [lines[0], f"{lines[1]} {lines[2]}"] if tall < 90 or wide > 300 else lines
    else:
        lines = [*lines[0].split(", ", 1), *lines[1:]]
        if not (wide > _LETTERS and tall > 18 * len(lines)):
            place, inside = float(x.max()) + 14, False
    for k, text in enumerate(lines):
        yield Note(place, level - 8.0 * (len(lines) - 1) + 4 + 16 * k, text, "word", "middle" if inside else "start")


def _loads(frame: Frame, scene: Scene, outlines: dict[str, Array]) -> Iterator[Mark]:
    """Arrows of P and Q at the top of the upper body, where they act; of its tilt or moment, and of bulk stress at both ends."""
    load, top = scene.load, float(frame.y.place(outlines["upper"][:, 1].max())) - 10
    line, contact = load.line_of_action, float(frame.y.place(0.0))
    x = float(np.clip(frame.x.place(line.x if line else 0.0), _SIDE, frame.width - _SIDE))  # the words below say where it is
    if line is not None:
        yield Curve([x, x], [contact - 0.3 * (contact - top), contact], "cycle-line")
    yield Arrow((x, top - 42), (x, top))
    right = x <= frame.width / 2  # there is more room
    yield Note(x - 9 if right else x + 9, top - 28, "P", "load", "end" if right else "start")
    if np.any(_samples(scene, 1) != 0):
        level = float(np.clip(frame.y.place(line.height), 16.0, contact - 8)) if line is not None else top - 8
        if level > top:  # beside the upper body, or within its left end
            left = float(frame.x.place(outlines["upper"][:, 0].min()))
            start = left - 64 if left > 64 + _SIDE else left + 6
            yield Note(start + 24, level - 7, "Q", "load", "middle")
        else:
            start = x + 14 if right else x - 74
            yield Note(*((x + 82, level + 5) if right else (x - 82, level + 5)), "Q", "load", "start" if right else "end")
        yield Arrow((start, level), (start + 60, level))
    if load.tilt is not None or load.moment is not None:
        # A positive tilt opens the gap at x > 0; a positive moment presses there, and so turns the other way.
        middle, turn = (x - 48.0, top - 17.0), 1.0 if load.tilt is not None else -1.0
        angle = np.linspace(-0.2, 1.2, 29) * np.pi
        arc = np.column_stack([middle[0] + turn * 18 * np.cos(angle), middle[1] - 18 * np.sin(angle)])
        yield Curve(arc[:-3, 0], arc[:-3, 1], "arrow")
        yield Arrow((arc[-8, 0], arc[-8, 1]), (arc[-1, 0], arc[-1, 1]))
        yield Note(middle[0], middle[1] + 5, "α" if load.tilt is not None else "M", "load", "middle")
    for name, stress in (("lower", load.bulk_stress_lower), ("upper", load.bulk_stress_upper)):
        if stress is not None:
            ends, level = frame.x.place(outlines[name][[0, 180], 0]), float(np.mean(frame.y.place(outlines[name][[0, -1], 1])))
            for end, outward in zip(ends.tolist(), (-1.0, 1.0), strict=True):
                yield Arrow((end + 3 * outward, level), (end + 23 * outward, level))
                yield Note(end + 13 * outward, level - 9, "σ", "load", "middle")


def _samples(scene: Scene, which: int) -> Array:
    """P or Q all along the path."""
    path = scene.load.path()
    return np.asarray(path.at(np.concatenate([sampled(leg, 181) for leg in path.legs(1)]))[which])


def _range(scene: Scene, which: int) -> str:
    loads = _samples(scene, which)
    least, most = (number(float(f"{value:.4g}")) for value in (loads.min(), loads.max()))
    return f"= {most}" if least == most else f"from {least} to {most}"
