"""The two bodies of a scene: meshed, condensed, facing each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.interface import Interface
from halfplane_fe.store import condensed
from meshes import BodyMesh, MeshSettings, SurfaceGrading, build
from scenes import Block, InputError, Pad, Scene

Array = NDArray[np.float64]

# Overlap of the faces as they are meshed that is admitted, over their largest gap: curved elements sag by a part of (h/a)^2 where
# the curvature of a face jumps.
_OVERLAP = 0.01
# The same over the width of the side that may touch, for faces without a gap: rounding.
_ROUNDING = 1e-9


def meshed_pair(scene: Scene, mesh: MeshSettings, grading: Callable[[float], SurfaceGrading]) -> tuple[BodyMesh, BodyMesh]:
    """Lower and upper body; one and the same where they have one shape and one element size.

    Parameters
    ----------
    grading : of a body whose elements are to be so many times as large
    """
    shapes = scene.bodies
    lower = build("lower", shapes.lower, scene.profile, grading(1.0), mesh)
    if shapes.lower == shapes.upper and mesh.upper_ratio == 1:
        return lower, lower
    return lower, build("upper", shapes.upper, scene.profile, grading(mesh.upper_ratio), mesh)


def condensed_pair(
    scene: Scene, bodies: tuple[BodyMesh, BodyMesh], datum_length: float, work: Counter[str]
) -> tuple[CondensedBody, CondensedBody]:
    """Both bodies condensed, from the store where they are there; `work` counts."""
    lower = condensed(bodies[0], scene.material.lower, datum_length, work)
    if scene.material.alike and bodies[1] is bodies[0]:
        return lower, lower
    return lower, condensed(bodies[1], scene.material.upper, datum_length, work)


def initial_gap(scene: Scene, interface: Interface) -> Array:
    """(n,) initial gap in the units of the scene's lengths: that of the faces as made, or the profile between two flat ones.

    Raises
    ------
    InputError
        If the faces overlap before any load.
    """
    if not scene.bodies.faces_are_true:
        return np.asarray(scene.profile.height(interface.x))
    x, distance = interface.nearest
    if -distance > max(_OVERLAP * float(interface.gap.max()), _ROUNDING * float(np.ptp(interface.x))):
        raise InputError(f"bodies: initial penetration: the faces overlap by {-distance:.6g} at x = {x:.6g}")
    return interface.gap


def check_supports(scene: Scene, sheared: bool) -> None:
    """Refuse bodies that a tangential load would push off their supports.

    Raises
    ------
    InputError
        For a block or pad on rollers with free sides under a tangential load.
    """
    for name, body in (("lower", scene.bodies.lower), ("upper", scene.bodies.upper)):
        if sheared and isinstance(body, Block | Pad) and body.base == "rollers" and body.sides == "free":
            raise InputError(
                f"bodies.{name}: nothing holds the {body.kind} against the tangential load, it slides off: its base is on "
                "rollers and its sides are free; take base = 'fixed' or sides = 'guided'"
            )


def face_room(scene: Scene) -> float:
    """Half the width of the narrower face [length]; infinite for half-planes."""
    return min(scene.bodies.lower.face_half_width, scene.bodies.upper.face_half_width)


def shapes_alike(scene: Scene) -> bool:
    """Whether the two bodies are each other's mirror image, materials included."""
    return scene.material.alike and scene.bodies.lower == scene.bodies.upper
