"""What finite elements refuse before they make a mesh of their own: loads, supports, a face too
narrow for the contact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfplane_fe.actuators import path_of
from halfplane_fe.path import check_admissible
from halfplane_fe.supports import check_bulk_stress, check_supports
from scenes import InputError, Scene

if TYPE_CHECKING:
    from halfplane_fe.scales import RoomForContact
    from meshes import MeshSettings


def require_solvable(scene: Scene, mesh: MeshSettings | None = None) -> RoomForContact | None:
    """Raise where `solve` would refuse a scene before it meshes it: by its loads, and of real
    bodies by an estimate of the largest contact on a coarse mesh.

    Parameters
    ----------
    mesh
        settings of the mesh that `solve` is to make, None for the default ones: whether the bodies
        can be meshed so finely is checked too

    Returns
    -------
    RoomForContact or None
        The estimate; None for half-planes, which have room for every contact.

    Raises
    ------
    InputError
        For a load path, supports or a face too narrow for the contact that `solve` refuses.
    ConvergenceError
        Where its coarse run does not converge.
    """
    check_loads(scene)
    if scene.bodies.half_planes:
        return None
    from halfplane_fe.task import room_for_contact  # noqa: PLC0415 - half-planes need no elements

    return room_for_contact(scene, mesh)


def check_loads(scene: Scene) -> None:
    """InputError for loads, or supports under them, that finite elements refuse."""
    check_bulk_stress(scene)
    if scene.bodies.faces_are_true and not scene.profile.symmetric:
        raise InputError(
            "profile: symmetric = false goes with half-planes and blocks: pads and cylinders are"
            " meshed mirror-symmetric"
        )
    is_driven = scene.load.is_driven
    check_admissible(path_of(scene), scene.friction.coefficient, is_driven=is_driven)
    check_supports(scene)
