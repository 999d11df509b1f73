"""gmsh-built bodies with named boundaries, their quality, and field files. The only user of gmsh and meshio.

Where to find what::

    bodies.py                              what a mesh is asked to be, and what it is
    build.py                               from a shape to a mesh: half_disc.py for half-planes, solids.py for all others
    grading.py, limits.py                  sizes of elements, and how many there may be
    mirrored.py                            half a body by gmsh, reflected
    quality.py                             whether a mesh is fit for use
    interrupts.py                          Ctrl-C that waits until what must not be cut in two is done
    files.py, foreign.py                   field files written, and those of other programs read
"""

from meshes.bodies import BodyMesh, MeshSettings, SurfaceGrading
from meshes.build import build, check
from meshes.files import PvdEntry, write_pvd, write_vtu
from meshes.foreign import FieldFrame, FieldPart, collected_files, joined, read_frames
from meshes.half_disc import half_disc
from meshes.quality import mesh_quality
from meshes.solids import solid

__all__ = [
    "BodyMesh",
    "FieldFrame",
    "FieldPart",
    "MeshSettings",
    "PvdEntry",
    "SurfaceGrading",
    "build",
    "check",
    "collected_files",
    "half_disc",
    "joined",
    "mesh_quality",
    "read_frames",
    "solid",
    "write_pvd",
    "write_vtu",
]


def __dir__() -> list[str]:
    return sorted(__all__)
