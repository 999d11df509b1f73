"""What finite elements refuse before they make a mesh of their own: loads, supports, a face too
narrow for the contact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfplane_fe.path import check_admissible, prescribed_path
from halfplane_fe.supports import check_bulk_stress, check_supports
from scenes import InputError, Scene
from scenes.frozen import validated

if TYPE_CHECKING:
    from halfplane_fe.scales import RoomForContact
    from meshes import MeshSettings


def require_solvable(scene: Scene, mesh: MeshSettings | None = None) -> RoomForContact | None:
    """Check in about a second whether finite elements can solve a scene: its loads, its supports,
    and, of bodies of finite size, whether their faces are wide enough for the contact.

    The contact is estimated on a coarse mesh.

    Parameters
    ----------
    scene
        to be checked
    mesh
        settings of the mesh of a later solution, None for the default ones: whether the bodies can
        be meshed so finely is checked too

    Returns
    -------
    RoomForContact or None
        The estimate; None for half-planes, which have room for every contact.

    Raises
    ------
    InputError
        For loads or supports that finite elements do not take, for a face too narrow.
    ConvergenceError
        Where the solution on the coarse mesh does not converge.
    """
    scene = validated(scene, Scene)
    check_loads(scene)
    if scene.bodies.half_planes:
        return None
    from halfplane_fe.task import room_for_contact  # noqa: PLC0415 - half-planes need no elements

    return room_for_contact(scene, mesh)


def check_loads(scene: Scene) -> None:
    """Raise InputError for loads, or supports under them, that finite elements refuse:

    - separation or gross sliding
    - bulk stress without ends that it could pull
    - bodies that slide off their supports
    - an unsymmetric profile on pads or cylinders
    """
    check_bulk_stress(scene)
    if scene.bodies.faces_are_true and not scene.profile.symmetric:
        raise InputError(
            "profile: symmetric = false goes with half-planes and blocks: pads and cylinders are"
            " meshed mirror-symmetric"
        )
    is_driven = scene.load.is_driven
    check_admissible(prescribed_path(scene), scene.friction.coefficient, is_driven=is_driven)
    check_supports(scene)
