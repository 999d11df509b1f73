"""Faces of bodies as they are made: arcs where half-plane theory has parabolas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.bodies import Cylinder, Pad, Shape
from scenes.profiles import FlatRounded, Hertz, Profile

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Face:
    """One side of the contact, mirror-symmetric in x = 0, in the body's own frame (y out of the body).

    Attributes
    ----------
    depth : how far the face at x lies below its point of first contact [length]; any shape
    arc : centre (x > 0 half) and radius of the arc that the face is from some place outwards, or None
    flat : whether the whole face is y = 0
    """

    depth: Callable[[Array], Array]
    arc: tuple[float, float] | None = None
    flat: bool = False


def arc_depth(x: Array, radius: float, flat_half_length: float = 0.0) -> Array:
    """Depth d = s^2/(R + sqrt(R^2 - s^2)) of an arc of radius R that starts at the end of a flat, s = |x| - b; |s| <= R.

    >>> arc_depth(np.array([0.0, 3.0, 5.0]), 5.0).tolist()
    [0.0, 1.0, 5.0]
    """
    beyond = np.maximum(np.abs(x) - flat_half_length, 0.0)
    rest = np.maximum(radius - beyond, 0.0)  # negative by rounding at the very end of the arc
    return np.asarray(beyond**2 / (radius + np.sqrt(rest * (radius + beyond))))


def face_of(shape: Shape, profile: Profile) -> Face:
    """The face of a body: flat, an arc, a flat with arcs, or the profile itself."""
    if isinstance(shape, Cylinder):
        return Face(lambda x: arc_depth(x, shape.radius), (0.0, shape.radius))
    if not isinstance(shape, Pad):
        return Face(np.zeros_like, flat=True)
    if isinstance(profile, Hertz):
        return Face(lambda x: arc_depth(x, profile.radius), (0.0, profile.radius))
    if isinstance(profile, FlatRounded):
        b = profile.flat_half_length
        return Face(lambda x: arc_depth(x, profile.radius, b), (b, profile.radius))
    return Face(profile.height)
