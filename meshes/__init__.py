"""gmsh-built bodies with named boundaries, their quality, and field files. The only user of gmsh
and meshio.

Where to find what::

    bodies.py                              what a mesh is asked to be, and what it is; sizes of
                                           elements, how many there may be
    solids.py                              from a shape to a mesh: half-discs, blocks, pads,
                                           cylinders, T-shapes, shouldered pads
    mirrored.py                            half a body by gmsh, reflected; the quality of a mesh
    interrupts.py                          Ctrl-C that waits until what must not be cut in two is
                                           done
    files.py                               field files written
"""

from meshes.bodies import BodyMesh, MeshSettings, SurfaceGrading
from meshes.files import PvdEntry, write_pvd, write_vtu
from meshes.mirrored import mesh_quality
from meshes.solids import Solid, build, check, half_disc, solid

__all__ = [
    "BodyMesh",
    "MeshSettings",
    "PvdEntry",
    "Solid",
    "SurfaceGrading",
    "build",
    "check",
    "half_disc",
    "mesh_quality",
    "solid",
    "write_pvd",
    "write_vtu",
]


def __dir__() -> list[str]:
    return sorted(__all__)
