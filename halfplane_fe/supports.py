"""How bodies are held: what a tangential load or a bulk stress would push off its supports. Nothing
is meshed for it.
"""

from __future__ import annotations

import numpy as np

from halfplane_fe.path import has_bulk_stress, prescribed_path
from scenes import Block, InputError, Pad, Scene, Shape, sampled_times

# Least number of instants of a curved load segment that are checked for a load other than 0: a
# harmonic load is 0 at few of them.
_N_INSTANTS = 25


def check_bulk_stress(scene: Scene) -> None:
    """Refuse a bulk stress (along x, far from the contact) in bodies without ends that could be
    pulled.

    Half-planes have their ends far away. A block with free sides is a specimen between grips: its
    stress is the mean of both ends. The sides of a guided block are held by walls. A pad or a
    cylinder is part of an indenter, whose stress along x comes from contact and base.

    `scene` has the shapes of both bodies and the load path, of loads or of movements in their
    place. A segment of the path may have a pair of bulk stresses, of the lower and the upper body.

    Raises
    ------
    InputError
        For a bulk stress other than 0 in any body but a half-plane or a block with free sides.
    """
    stress_histories = [
        segment.bulk for segment in prescribed_path(scene).segments(1) if segment.bulk is not None
    ]
    for body_number, name in enumerate(("lower", "upper")):
        shape = getattr(scene.bodies, name)
        # Is the bulk stress other than 0 at any of 25 instants of a segment? `loads` of a stress
        # history are the stresses of the lower and of the upper body.
        is_pulled = any(
            np.any(stress_history.loads(sampled_times(stress_history, _N_INSTANTS))[body_number])
            for stress_history in stress_histories
        )
        if is_pulled and not (shape.kind == "half_plane" or has_free_ends(shape)):
            kind = f"{shape.kind} with guided sides" if isinstance(shape, Block) else shape.kind
            raise InputError(
                f"load.bulk_stress_{name}: nothing pulls the ends of the {name} body, a {kind};"
                " half-planes take bulk stress, and blocks with sides = 'free'"
            )


def has_free_ends(body: Shape) -> bool:
    """Whether a body is a block with free sides: these are its ends, which a bulk stress can
    pull.
    """
    return isinstance(body, Block) and body.sides == "free"


def check_supports(scene: Scene) -> None:
    """Refuse bodies that a tangential load would push off their supports: blocks and pads on
    rollers with free sides.

    A block whose ends are pulled by a bulk stress is held there. `base` and `sides` of a block or
    pad state how it is supported.

    Raises
    ------
    InputError
        For such a body; the message names supports that would hold it.
    """
    is_pushed = has_tangential_load(scene)
    for name, shape in (("lower", scene.bodies.lower), ("upper", scene.bodies.upper)):
        if not is_pushed or not isinstance(shape, Block | Pad):
            continue
        is_held_by_ends = has_free_ends(shape) and has_bulk_stress(prescribed_path(scene))
        if shape.base == "rollers" and shape.sides == "free" and not is_held_by_ends:
            raise InputError(
                f"bodies.{name}: nothing holds the {shape.kind} against the tangential load, it"
                " slides off: its base is on rollers and its sides are free; take base = 'fixed'"
                " or sides = 'guided'"
            )


def has_tangential_load(scene: Scene) -> bool:
    """Whether the load path of a scene has a tangential load other than 0, or a tangential movement
    in its place, at any of 25 instants of a segment or more.
    """
    return any(
        np.any(segment.loads(sampled_times(segment, _N_INSTANTS))[1] != 0)
        for segment in prescribed_path(scene).segments(1)
    )


def least_face_half_width(scene: Scene) -> float:
    """Half the width of the narrower face [length]; infinite for half-planes."""
    return min(scene.bodies.lower.face_half_width, scene.bodies.upper.face_half_width)


def bodies_are_alike(scene: Scene) -> bool:
    """Whether the two bodies are each other's mirror image, materials included."""
    return scene.material.alike and scene.bodies.lower == scene.bodies.upper
