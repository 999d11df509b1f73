"""The sketch of a scene: both bodies to scale, what holds them, the loads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reports.body_words import bodies_in_words
from reports.charts.marks import Frame, element, path_of, words
from reports.charts.plate import Plate
from reports.charts.scale import Scale
from reports.drawing import Table
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
_WIDTH, _MOST, _ROOM = 440.0, 310.0, 62.0


def sketch(scene: Scene, half_width: float) -> Plate:
    """Both bodies to scale with supports, loads and the place of the contact.

    Parameters
    ----------
    half_width : of the contact, drawn to scale [length]
    """
    length = units(scene)[1]
    outlines = {name: outline(scene, name, half_width) for name in ("lower", "upper")}
    frame = _frame(outlines)
    parts = []
    for name, side in (("lower", 1.0), ("upper", -1.0)):
        shape = getattr(scene.bodies, name)
        parts += [_body(frame, outlines[name], shape, name), _supports(frame, shape, outlines[name], side)]
    left, right = frame.x.place([-half_width, half_width])
    level = float(frame.y.place(0.0))
    parts.append(element("path", d=path_of([left, right], [level, level]), class_="contact-line"))
    parts += [_label(frame, scene, name, outlines[name]) for name in outlines]
    parts.append(_loads(frame, scene, outlines["upper"]))
    alt = bodies_in_words(scene)
    box = f"0 0 {frame.width:g} {frame.height:g}"
    picture = element(
        "svg", "".join(parts), xmlns="http://www.w3.org/2000/svg", viewBox=box, role="img", aria_label=alt, class_="sketch"
    )
    columns: Table = {
        "body": [name for name in outlines for _ in outlines[name]],
        f"x [{length}]": np.concatenate([points[:, 0] for points in outlines.values()]),
        f"y [{length}]": np.concatenate([points[:, 1] for points in outlines.values()]),
    }
    caption = (
        f"To scale{'; half-planes are cut off at the dotted lines' if _cut(scene) else ''}. Thick line: the contact, "
        f"2 a_ref = {number(2 * half_width)} {length} wide. P {_range(scene, 0)}, Q {_range(scene, 1)} {load_unit(scene)}."
    )
    return Plate("bodies", "Bodies, supports and loads", caption, alt, (picture,), columns, columns=1)


def _frame(outlines: dict[str, Array]) -> Frame:
    """Both bodies with one scale in both directions, room above for the loads and all round for supports."""
    points = np.concatenate(list(outlines.values()))
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    side = 26.0
    unit = max((right - left) / (_WIDTH - 2 * side), (high - low) / (_MOST - _ROOM - side))
    height = (high - low) / unit + _ROOM + side
    middle, half = (left + right) / 2, (_WIDTH / 2 - side) * unit
    across = Scale(float(middle - half), float(middle + half), side, _WIDTH - side)
    return Frame(across, Scale(float(low), float(high), float(height - side), _ROOM), _WIDTH, float(height))


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
    height = _height(shape, width)
    corners = np.array([[width, -side * height], [-width, -side * height]])
    return face if isinstance(shape, Cylinder) else np.vstack([face, corners])


def _height(shape: Shape, width: float) -> float:
    match shape:
        case Cylinder(radius=radius):
            return radius
        case HalfPlane():
            return 0.5 * width
        case _:
            return float(shape.height)


def _cut(scene: Scene) -> bool:
    return any(isinstance(body, HalfPlane) for body in (scene.bodies.lower, scene.bodies.upper))


def _places(frame: Frame, points: Array) -> tuple[Array, Array]:
    return frame.x.place(points[:, 0]), frame.y.place(points[:, 1])


def _body(frame: Frame, points: Array, shape: Shape, name: str) -> str:
    """A filled body; a half-plane has a line along its face alone, for it goes on everywhere else."""
    x, y = _places(frame, points)
    filled = element("path", d=path_of(x, y) + "Z", class_=f"body {name}")
    if not isinstance(shape, HalfPlane):
        return filled + element("path", d=path_of(x, y) + "Z", class_="body-line")
    corners = [180, 181, 182, 0]
    return (
        filled
        + element("path", d=path_of(x[:181], y[:181]), class_="body-line")
        + element("path", d=path_of(x[corners], y[corners]), class_="cut-line")
    )


def _supports(frame: Frame, shape: Shape, points: Array, side: float) -> str:
    """Hatching where a body is fixed, rollers where it is guided; what holds the upper body moves, and has no hatching."""
    if isinstance(shape, HalfPlane):
        return ""
    half = shape.face_half_width
    left, right = (float(v) for v in frame.x.place([-half, half]))
    base = float(frame.y.place(points[np.argmax(-side * points[:, 1]), 1]))
    rollers = not isinstance(shape, Cylinder) and shape.base == "rollers"
    parts = [_wall((left, base), (right, base), (0.0, side), rollers=rollers, hatched=side > 0)]
    if not isinstance(shape, Cylinder) and shape.sides == "guided":
        top = float(frame.y.place(points[0, 1]))
        parts += [
            _wall((x, base), (x, top), (outward, 0.0), rollers=True, hatched=side > 0)
            for x, outward in ((left, -1.0), (right, 1.0))
        ]
    return "".join(parts)


def _wall(
    start: tuple[float, float], end: tuple[float, float], outward: tuple[float, float], *, rollers: bool, hatched: bool
) -> str:
    """A rigid plane along start-end, rollers between it and the body where asked; hatched where it is at rest."""
    first, last, normal, size = np.array(start), np.array(end), np.array(outward), 10.0
    parts = []
    if rollers:
        for share in np.linspace(0.08, 0.92, 7):
            x, y = first + share * (last - first) + normal * size / 3
            parts.append(element("circle", cx=float(x), cy=float(y), r=size / 3, class_="roller"))
        first, last = first + normal * 2 * size / 3, last + normal * 2 * size / 3
    parts.append(element("path", d=path_of([first[0], last[0]], [first[1], last[1]]), class_="wall" if hatched else "wall moving"))
    if hatched:
        along = (last - first) / np.hypot(*(last - first))
        feet = first + np.linspace(0, 1, max(int(np.hypot(*(last - first)) / 8), 4))[:, None] * (last - first)
        tips = feet + 0.7 * size * (normal - along)
        parts.append(
            element("path", d="".join(path_of([a[0], b[0]], [a[1], b[1]]) for a, b in zip(feet, tips, strict=True)), class_="hatch")
        )
    return "".join(parts)


def _label(frame: Frame, scene: Scene, name: str, points: Array) -> str:
    """Kind, sizes and material in the middle of a body, or beside one that is too narrow for them."""
    shape, material = getattr(scene.bodies, name), getattr(scene.material, name)
    _, length, stress = units(scene)
    size = {
        "half_plane": "",
        "cylinder": f", R = {number(getattr(shape, 'radius', 0.0))} {length}",
    }.get(shape.kind, f", {number(getattr(shape, 'width', 0.0))} × {number(getattr(shape, 'height', 0.0))} {length}")
    lines = [
        f"{name}: {shape.kind.replace('_', '-')}{size}",
        f"E = {number(material.young_modulus)} {stress},",
        f"ν = {number(material.poisson_ratio)}",
    ]
    x, y = _places(frame, points)
    wide, tall = float(np.ptp(x)), float(np.ptp(y))
    level = float(y.min()) + tall * (0.58 if name == "lower" else 0.42)
    if wide > _WIDE_ENOUGH * frame.width:
        lines = [lines[0], f"{lines[1]} {lines[2]}"] if tall < 90 or wide > 300 else lines
        return _lines(lines, float(x.min()) + wide / 2, level, "middle")
    narrow = [*lines[0].split(", ", 1), *lines[1:]]
    if wide > _LETTERS and tall > 18 * len(narrow):
        return _lines(narrow, float(x.min()) + wide / 2, level, "middle")
    return _lines(narrow, float(x.max()) + 14, level, "start")


def _lines(lines: list[str], x: float, middle: float, anchor: str) -> str:
    top = middle - 8.0 * (len(lines) - 1) + 4
    return "".join(words(x, top + 16 * k, text, class_="word", text_anchor=anchor) for k, text in enumerate(lines))


def _loads(frame: Frame, scene: Scene, upper: Array) -> str:
    """Arrows of P and Q at the top of the upper body."""
    x, y = float(frame.x.place(0.0)), float(frame.y.place(upper[:, 1].max())) - 10
    parts = [_arrow(x, y - 42, x, y), words(x - 9, y - 28, "P", class_="load", text_anchor="end")]
    if np.any(_samples(scene)[1] != 0):
        parts += [_arrow(x + 14, y - 8, x + 74, y - 8), words(x + 82, y - 3, "Q", class_="load")]
    return "".join(parts)


def _arrow(x0: float, y0: float, x1: float, y1: float) -> str:
    """A line from the first to the second place with a head at the second."""
    along = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
    across, tip = np.array([-along[1], along[0]]), np.array([x1, y1])
    head = np.array([tip, tip - 11 * along + 4.5 * across, tip - 11 * along - 4.5 * across])
    end = tip - 9 * along
    line = element("path", d=path_of([x0, end[0]], [y0, end[1]]), class_="arrow")
    return line + element("path", d=path_of(head[:, 0], head[:, 1]) + "Z", class_="arrow-head")


def _samples(scene: Scene) -> tuple[Array, Array]:
    """P and Q all along the path."""
    path = scene.load.path()
    times = np.concatenate([sampled(leg, 181) for leg in path.legs(1)])
    normal, tangential = path.at(times)
    return np.asarray(normal), np.asarray(tangential)


def _range(scene: Scene, which: int) -> str:
    loads = _samples(scene)[which]
    least, most = (number(float(f"{value:.4g}")) for value in (loads.min(), loads.max()))
    return f"= {most}" if least == most else f"from {least} to {most}"
