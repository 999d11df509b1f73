"""gmsh-built bodies with named boundaries, their quality, and field files. The only user of gmsh
and meshio.

Where to find what::

    bodies.py                              settings of a mesh, sizes of its elements, and the
                                           meshed body; how many nodes there may be
    solids.py                              from a shape to a mesh: half-discs, blocks, pads,
                                           cylinders, T-shapes, shouldered pads
    mirrored.py                            half a body by gmsh, reflected; the quality of a mesh
    interrupts.py                          Ctrl-C held back until a piece of work is complete
    files.py                               field files written
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
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

_HOME = {
    "BodyMesh": "meshes.bodies",
    "MeshSettings": "meshes.bodies",
    "PvdEntry": "meshes.files",
    "Solid": "meshes.solids",
    "SurfaceGrading": "meshes.bodies",
    "build": "meshes.solids",
    "check": "meshes.solids",
    "half_disc": "meshes.solids",
    "mesh_quality": "meshes.mirrored",
    "solid": "meshes.solids",
    "write_pvd": "meshes.files",
    "write_vtu": "meshes.files",
}


def __getattr__(name: str) -> Any:
    # gmsh and scikit-fem are loaded where a mesh is made, not for Ctrl-C to wait.
    if name not in _HOME:
        raise AttributeError(f"module 'meshes' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
