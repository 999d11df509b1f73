"""What the sketches of the library show, as plain lines: the two bodies, and Q over P. No drawing library."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes import Cylinder, HalfPlane, LoadSegment, Scene, Shape, sampled
from scenes.bodies import face_of

Array = NDArray[np.float64]

# The gap of flat faces as drawn, at the end of the face, over half its width; true gaps are a thousandth of it and not seen.
_GAP = 0.3
# Half-planes as drawn: half-width over that of the body that they face, or over the last kink of the profile; depth over it.
_BESIDE, _BEYOND, _DEEP = 1.3, 2.5, 0.45


@dataclass(frozen=True, eq=False)
class Silhouette:
    """A body: its face from left to right (n, 2) and its whole outline; whether it is a half-plane, and whether walls guide it."""

    face: Array
    outline: Array
    half_plane: bool
    guided: bool


def silhouettes(scene: Scene) -> tuple[Silhouette, Silhouette]:
    """Lower and upper body to scale [length], the lower below y = 0; where both faces are flat the gap is exaggerated."""
    lower, upper = scene.bodies.lower, scene.bodies.upper
    return _silhouette(scene, lower, upper, -1.0), _silhouette(scene, upper, lower, 1.0)


def _silhouette(scene: Scene, shape: Shape, other: Shape, side: float) -> Silhouette:
    half = _half_width(scene, shape, other)
    x = half * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 61))
    rise = face_of(shape, scene.profile).depth(x)
    if side > 0 and not scene.bodies.faces_are_true:
        gap = scene.profile.height(x)
        rise = gap / gap[-1] * min(_GAP * half, _height(shape, half) / 2)
    top = max(_height(shape, half), float(rise.max()))
    face = np.column_stack([x, side * rise])
    corners = [] if isinstance(shape, Cylinder) else [[half, side * top], [-half, side * top]]
    outline = np.vstack([face, np.array(corners).reshape(-1, 2), face[:1]])
    return Silhouette(face, outline, isinstance(shape, HalfPlane), getattr(shape, "sides", "free") == "guided")


def _half_width(scene: Scene, shape: Shape, other: Shape) -> float:
    if not isinstance(shape, HalfPlane):
        return shape.face_half_width
    if not isinstance(other, HalfPlane):
        return _BESIDE * other.face_half_width
    return _BEYOND * max(scene.profile.kinks, default=1.0)


def _height(shape: Shape, half: float) -> float:
    match shape:
        case Cylinder(radius=radius):
            return radius
        case HalfPlane():
            return _DEEP * half
    return float(shape.height)


@dataclass(frozen=True, eq=False)
class Loop:
    """Q over P: points (P, Q) of the initial loading and of what follows it, (n, 2) each [force / thickness]."""

    initial_loading: Array
    cycle: Array

    @property
    def points(self) -> Array:
        """All of them."""
        return np.vstack([self.initial_loading, self.cycle])


def loop(scene: Scene) -> Loop:
    """The loads of a scene; a path that does not repeat is all cycle but for its first line."""
    path = scene.load.path()
    initial_loading, cycle = (
        (path.initial_loading, path.cycle) if path.cycle else (path.initial_loading[:1], path.initial_loading[1:])
    )
    first, rest = _points(initial_loading), _points(cycle)
    return Loop(first, rest if len(rest) else first[-1:])


def _points(legs: Sequence[LoadSegment]) -> Array:
    parts = [np.column_stack(leg.loads(sampled(leg, 121))) for leg in legs]
    return np.vstack(parts) if parts else np.empty((0, 2))
