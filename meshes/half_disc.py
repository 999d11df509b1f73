"""The half-disc that stands for a half-plane, graded to the contact and mirror-symmetric to the last bit."""

from __future__ import annotations

import itertools

import gmsh
import numpy as np

from meshes.bodies import BodyMesh, Cells, SurfaceGrading
from meshes.grading import scaled_grading, size_field, surface_points
from meshes.mirrored import mirrored_mesh
from meshes.quality import mesh_quality


def half_disc(name: str, grading: SurfaceGrading, growth: float = 0.2, order: int = 2, cells: Cells = "triangles") -> BodyMesh:
    """A half-disc y <= 0 of radius `grading.radius`, meshed by gmsh.

    One quarter is meshed and reflected in x = 0, so that a symmetric contact stays symmetric in rounding too.
    Boundaries: "contact" (|x| <= grading.outer), "free" (the rest of y = 0), "far_field" (the arc).

    Returns
    -------
    BodyMesh
        MeshTri2 of six-node triangles with curved arc for order 2, MeshTri of three-node ones for order 1; MeshQuad2 of nine-node
        quadrilaterals, MeshQuad.
    """
    unit = scaled_grading(grading, 1 / grading.outer).drawn_for(cells)
    mesh = mirrored_mesh(lambda: _quarter(unit), size_field(unit, growth), order, cells).scaled(float(grading.outer))
    exact_area = np.pi * grading.radius**2 / 2
    return BodyMesh(name, mesh, grading, mesh_quality(mesh, exact_area))


def _quarter(grading: SurfaceGrading) -> dict[str, list[int]]:
    """Draws the quarter x >= 0 of the half-disc."""
    geo = gmsh.model.geo
    surface = [geo.addPoint(float(x), 0, 0) for x in surface_points(grading)]
    corner, bottom = geo.addPoint(grading.radius, 0, 0), geo.addPoint(0, -grading.radius, 0)
    contact = [geo.addLine(a, b) for a, b in itertools.pairwise(surface)]
    free = geo.addLine(surface[-1], corner)
    arc = geo.addCircleArc(corner, surface[0], bottom)
    axis = geo.addLine(bottom, surface[0])
    geo.addPlaneSurface([geo.addCurveLoop([*contact, free, arc, axis])])
    for line in contact:
        geo.mesh.setTransfiniteCurve(line, 2)
    return {"contact": contact, "free": [free], "far_field": [arc]}
