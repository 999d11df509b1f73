"""From a shape to a mesh."""

from __future__ import annotations

from meshes.bodies import BodyMesh, MeshSettings, SurfaceGrading
from meshes.half_disc import half_disc
from meshes.limits import check_count
from meshes.solids import check_face, solid
from scenes import HalfPlane, Profile, Shape


def check(name: str, shape: Shape, profile: Profile, grading: SurfaceGrading, mesh: MeshSettings) -> None:
    """InputError for all that `build` refuses, before gmsh is asked."""
    check_count(name, grading, mesh.growth, mesh.order)
    if not isinstance(shape, HalfPlane):
        check_face(name, shape, profile, grading)


def build(name: str, shape: Shape, profile: Profile, grading: SurfaceGrading, mesh: MeshSettings) -> BodyMesh:
    """The mesh of a body: a half-disc for a half-plane, the body itself for a block, a pad or a cylinder.

    Parameters
    ----------
    name : "lower" or "upper", as the scene calls it
    profile : the face of a pad
    grading : of the contact side
    mesh : growth, order and kind of the elements

    Raises
    ------
    InputError
        Where the mesh would be too large for memory, with the limit; where a solid's face is shorter than the contact.
    """
    check(name, shape, profile, grading, mesh)
    if isinstance(shape, HalfPlane):
        return half_disc(name, grading, mesh.growth, mesh.order, mesh.cells)
    return solid(name, shape, profile, grading, mesh.growth, mesh.order, mesh.cells)
