"""The sketch of a scene: both bodies to scale, what holds them, the loads."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray

from reports.body_words import bodies_in_words
from reports.drawing import BODY_COLOURS, QUIET, RESULT, Drawing, Table, canvas
from reports.units import load_unit, number, units
from scenes import Cylinder, HalfPlane, Pad, Scene, Shape

Array = NDArray[np.float64]

# Half the width of a half-plane as drawn, over a or over the half-width of the body that it faces.
_SHOWN_OF_CONTACT, _SHOWN_OF_BODY = 6.0, 1.3
# Share of the sketch that a body takes at least where its label stands inside.
_WIDE_ENOUGH = 0.45


def sketch(scene: Scene, half_width: float) -> Drawing:
    """Both bodies to scale with supports, loads and the place of the contact.

    Parameters
    ----------
    half_width : of the contact, drawn to scale [length]
    """
    length = units(scene)[1]
    outlines = {name: outline(scene, name, half_width) for name in ("lower", "upper")}
    size = max(float(np.ptp(np.concatenate(list(outlines.values())), axis=0).max()), 1e-300)
    with canvas(4.4, 4.1) as figure:
        axes = figure.subplots()
        figure.subplots_adjust(left=0.01, right=0.99, top=0.99, bottom=0.13)
        for name, side in (("lower", 1.0), ("upper", -1.0)):
            shape = getattr(scene.bodies, name)
            _body(axes, outlines[name], shape, name)
            _supports(axes, shape, outlines[name], side, 0.035 * size)
            _label(axes, scene, name, outlines[name], size)
        axes.plot([-half_width, half_width], [0, 0], color=RESULT, lw=3.0, solid_capstyle="butt", zorder=5)
        _loads(axes, scene, outlines["upper"], size)
        _frame(axes, outlines, size)
        axes.set_xlabel(
            f"to scale; red: contact of width 2 a_ref = {number(2 * half_width)} {length}\n"
            f"P {_range(scene, 0)}, Q {_range(scene, 1)} {load_unit(scene)}",
            fontsize=8.5,
        )
    words = bodies_in_words(scene)
    columns: Table = {
        "body": [name for name in outlines for _ in outlines[name]],
        f"x [{length}]": np.concatenate([points[:, 0] for points in outlines.values()]),
        f"y [{length}]": np.concatenate([points[:, 1] for points in outlines.values()]),
    }
    return Drawing(
        "bodies", "Bodies, supports and loads", "Half-planes are cut off." if _cut(scene) else "", words, figure, columns
    )


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
    face = np.column_stack([x, -side * _depth(shape, scene, x)])
    height = _height(shape, width)
    corners = np.array([[width, -side * height], [-width, -side * height]])
    return face if isinstance(shape, Cylinder) else np.vstack([face, corners])


def _depth(shape: Shape, scene: Scene, x: Array) -> Array:
    if not isinstance(shape, Pad | Cylinder):
        return np.zeros_like(x)
    from meshes.faces import face_of

    return face_of(shape, scene.profile).depth(x)


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


def _body(axes: Axes, points: Array, shape: Shape, name: str) -> None:
    """A filled body; a half-plane has a line along its face alone, for it goes on everywhere else."""
    cut = isinstance(shape, HalfPlane)
    axes.add_patch(Polygon(points, facecolor=BODY_COLOURS[name], edgecolor="none" if cut else "#333333", lw=1.0, joinstyle="round"))
    if cut:
        axes.plot(*points[:181].T, color="#333333", lw=1.0)
        axes.plot(*points[[180, 181, 182, 0]].T, color=QUIET, lw=0.8, ls=(0, (2, 3)))


def _supports(axes: Axes, shape: Shape, points: Array, side: float, size: float) -> None:
    """Hatching where a body is fixed, rollers where it is guided; what holds the upper body moves, and has no hatching."""
    if isinstance(shape, HalfPlane):
        return
    low = points[np.argmax(-side * points[:, 1]), 1]
    half = shape.face_half_width
    rollers = not isinstance(shape, Cylinder) and shape.base == "rollers"
    _wall(axes, np.array([-half, low]), np.array([half, low]), np.array([0.0, -side]), size, rollers=rollers, hatched=side > 0)
    if not isinstance(shape, Cylinder) and shape.sides == "guided":
        top = points[0, 1]
        for x, outward in ((-half, -1.0), (half, 1.0)):
            _wall(axes, np.array([x, low]), np.array([x, top]), np.array([outward, 0.0]), size, rollers=True, hatched=side > 0)


def _wall(axes: Axes, start: Array, end: Array, outward: Array, size: float, *, rollers: bool, hatched: bool) -> None:
    """A rigid plane along start-end, rollers between it and the body where asked; hatched where it is at rest."""
    if rollers:
        for share in np.linspace(0.08, 0.92, 7):
            centre = start + share * (end - start) + outward * size / 3
            axes.add_patch(
                Circle((float(centre[0]), float(centre[1])), size / 3, facecolor="white", edgecolor="#333333", lw=0.8, zorder=4)
            )
        start, end = start + outward * 2 * size / 3, end + outward * 2 * size / 3
    axes.plot(*np.array([start, end]).T, color="#333333", lw=2.2 if hatched else 4.0, solid_capstyle="butt")
    if hatched:
        along = (end - start) / np.linalg.norm(end - start)
        feet = start + np.linspace(0, 1, max(int(np.linalg.norm(end - start) / (0.6 * size)), 4))[:, None] * (end - start)
        axes.add_collection(
            LineCollection(list(np.stack([feet, feet + size * (outward - along) * 0.7], axis=1)), colors="#333333", lw=0.7)
        )


def _label(axes: Axes, scene: Scene, name: str, points: Array, overall: float) -> None:
    """Kind, sizes and material in the middle of a body, or beside one that is too narrow for them."""
    shape, material = getattr(scene.bodies, name), getattr(scene.material, name)
    _, length, stress = units(scene)
    size = {
        "half_plane": "",
        "cylinder": f", R = {number(getattr(shape, 'radius', 0.0))} {length}",
    }.get(shape.kind, f" {number(getattr(shape, 'width', 0.0))} × {number(getattr(shape, 'height', 0.0))} {length}")
    low, high = float(points[:, 1].min()), float(points[:, 1].max())
    elastic = f"E = {number(material.young_modulus)} {stress}, ν = {number(material.poisson_ratio)}"
    words = f"{name}: {shape.kind.replace('_', '-')}{size}\n{elastic}"
    half = float(points[:, 0].max())
    height = low + (high - low) * (0.42 if name == "lower" else 0.58)
    if 2 * half > _WIDE_ENOUGH * overall:
        axes.text(0, height, words, ha="center", va="center", fontsize=8)
    else:
        axes.text(
            half + 0.04 * overall, height, words.replace(", ν", "\nν").replace(": ", ":\n"), ha="left", va="center", fontsize=8
        )


def _loads(axes: Axes, scene: Scene, upper: Array, size: float) -> None:
    """Arrows of P and Q at the top of the upper body."""
    top = float(upper[:, 1].max()) + 0.04 * size
    style = {"arrowstyle": "-|>", "lw": 1.8, "color": RESULT, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (0, top), (0, top + 0.13 * size), arrowprops=style)
    axes.text(0.02 * size, top + 0.09 * size, "P", color=RESULT, fontsize=10, fontweight="bold")
    if np.any(_samples(scene)[1] != 0):
        axes.annotate("", (0.2 * size, top + 0.03 * size), (0.06 * size, top + 0.03 * size), arrowprops=style)
        axes.text(0.21 * size, top + 0.03 * size, "Q", color=RESULT, fontsize=10, fontweight="bold", va="center")


def _samples(scene: Scene) -> tuple[Array, Array]:
    """P and Q all along the path."""
    path = scene.load.path()
    times = np.concatenate([np.linspace(leg.start, leg.end, 181) for leg in path.legs(1)])
    normal, tangential = path.at(times)
    return np.asarray(normal), np.asarray(tangential)


def _range(scene: Scene, which: int) -> str:
    loads = _samples(scene)[which]
    least, most = (number(float(f"{value:.4g}")) for value in (loads.min(), loads.max()))
    return f"= {most}" if least == most else f"from {least} to {most}"


def _frame(axes: Axes, outlines: dict[str, Array], size: float) -> None:
    points = np.concatenate(list(outlines.values()))
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.06 * size
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin + 0.14 * size)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
