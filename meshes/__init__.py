"""gmsh-built bodies with named boundaries, their quality, and field files. The only user of gmsh and meshio."""

from meshes.bodies import BodyMesh, MeshSettings, SurfaceGrading
from meshes.build import build
from meshes.files import PvdEntry, write_pvd, write_vtu
from meshes.foreign import FieldFrame, collected_files, read_frames
from meshes.half_disc import half_disc
from meshes.quality import mesh_quality
from meshes.solids import solid

__all__ = [
    "BodyMesh",
    "FieldFrame",
    "MeshSettings",
    "PvdEntry",
    "SurfaceGrading",
    "build",
    "collected_files",
    "half_disc",
    "mesh_quality",
    "read_frames",
    "solid",
    "write_pvd",
    "write_vtu",
]
