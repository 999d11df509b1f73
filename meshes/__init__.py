"""gmsh-built bodies with named boundaries, their quality, and field files. The only user of gmsh and meshio."""

from meshes.bodies import BodyMesh, MeshSettings, SurfaceGrading
from meshes.build import build
from meshes.files import PvdEntry, write_pvd, write_vtu
from meshes.half_disc import half_disc
from meshes.quality import mesh_quality
from meshes.solids import solid

__all__ = [
    "BodyMesh",
    "MeshSettings",
    "PvdEntry",
    "SurfaceGrading",
    "build",
    "half_disc",
    "mesh_quality",
    "solid",
    "write_pvd",
    "write_vtu",
]
