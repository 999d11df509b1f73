"""The half-disc that stands for a half-plane, graded to the contact and mirror-symmetric to the last bit."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import gmsh
import numpy as np
import skfem
from numpy.typing import NDArray

from meshes.bodies import BodyMesh, SurfaceGrading
from meshes.quality import mesh_quality

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# gmsh's node order of a six-node triangle after a reflection: corners 0 2 1, so sides 20 21 10.
_REFLECTED = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3]}


@dataclass(frozen=True)
class _Triangles:
    points: Array  # (n_points, 2)
    elements: Indices  # (n_elements, 3 or 6), gmsh's order
    named: dict[str, Indices]  # points of each boundary


def half_disc(name: str, grading: SurfaceGrading, growth: float = 0.2, order: int = 2) -> BodyMesh:
    """A half-disc y <= 0 of radius `grading.radius`, meshed by gmsh.

    One quarter is meshed and reflected in x = 0, so that a symmetric contact stays symmetric in rounding too.
    Boundaries: "contact" (|x| <= grading.outer), "free" (the rest of y = 0), "far_field" (the arc).

    Returns
    -------
    BodyMesh
        MeshTri2 of six-node triangles with curved arc for order 2, MeshTri of three-node ones for order 1.
    """
    unit = _scaled(grading, 1 / grading.outer)
    whole = _corners_first(_reflect(_quarter(unit, growth, order), tolerance=1e-9))
    points = np.ascontiguousarray(whole.points.T) * grading.outer
    elements = np.ascontiguousarray(whole.elements.T)
    n_corners = int(elements[:3].max()) + 1
    skfem.MeshTri(points[:, :n_corners].copy(), elements[:3].copy()).is_valid(raise_=True)
    mesh = skfem.MeshTri2(points, elements) if order == 2 else skfem.MeshTri(points, elements)
    mesh = mesh.with_boundaries({key: _facets(mesh, nodes) for key, nodes in whole.named.items()})
    exact_area = np.pi * grading.radius**2 / 2
    return BodyMesh(name, mesh, grading, mesh_quality(mesh, exact_area))


def _scaled(grading: SurfaceGrading, factor: float) -> SurfaceGrading:
    # To twelve digits: on the last one gmsh makes another mesh, and the answer would depend on the scene's units.
    values = (grading.inner, grading.outer, grading.size, grading.edge_size, grading.radius)
    return SurfaceGrading(*(float(f"{value * factor:.12g}") for value in values))


def _surface_points(grading: SurfaceGrading) -> Array:
    """Corner points of the surface elements on 0 <= x <= outer: even on either side of `inner`."""
    inside = np.linspace(0, grading.inner, max(round(grading.inner / grading.size), 1) + 1 if grading.inner > 0 else 1)
    outside = np.linspace(grading.inner, grading.outer, max(round((grading.outer - grading.inner) / grading.edge_size), 1) + 1)
    return np.concatenate([inside[:-1], outside])


def _size_field(grading: SurfaceGrading, growth: float) -> Callable[..., float]:
    """Element size at a point: that of the nearest surface elements, growing with the distance."""

    def size(_dim: int, _tag: int, x: float, y: float, _z: float, _size: float) -> float:
        from_edges = np.hypot(max(abs(x) - grading.outer, grading.inner - abs(x), 0.0), y)
        from_middle = np.hypot(max(abs(x) - grading.inner, 0.0), y)
        fine = grading.edge_size + growth * float(from_edges)
        return min(fine, grading.size + growth * float(from_middle)) if grading.inner > 0 else fine

    return size


@contextmanager
def _gmsh_model(name: str) -> Iterator[None]:
    # gmsh is one global state: entered here, left here, whatever happens.
    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.AbortOnError", 2)
        for rule in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
            gmsh.option.setNumber(f"Mesh.MeshSize{rule}", 0)
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.option.setNumber("Mesh.RandomSeed", 1)
        gmsh.model.add(name)
        yield
    finally:
        gmsh.finalize()


def _quarter(grading: SurfaceGrading, growth: float, order: int) -> _Triangles:
    """The quarter x >= 0 of the half-disc."""
    with _gmsh_model("quarter"):
        geo = gmsh.model.geo
        surface = [geo.addPoint(float(x), 0, 0) for x in _surface_points(grading)]
        corner, bottom = geo.addPoint(grading.radius, 0, 0), geo.addPoint(0, -grading.radius, 0)
        contact = [geo.addLine(a, b) for a, b in itertools.pairwise(surface)]
        free = geo.addLine(surface[-1], corner)
        arc = geo.addCircleArc(corner, surface[0], bottom)
        axis = geo.addLine(bottom, surface[0])
        geo.addPlaneSurface([geo.addCurveLoop([*contact, free, arc, axis])])
        for line in contact:
            geo.mesh.setTransfiniteCurve(line, 2)
        geo.synchronize()
        gmsh.model.mesh.setSizeCallback(_size_field(grading, growth))
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        return _read({"contact": contact, "free": [free], "far_field": [arc]}, order)


def _read(curves: dict[str, list[int]], order: int) -> _Triangles:
    """Points, triangles and boundary points of gmsh's current model."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    place = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    place[tags.astype(np.int64)] = np.arange(len(tags))
    _, _, connectivity = gmsh.model.mesh.getElements(2)
    elements = place[np.concatenate(connectivity).astype(np.int64)].reshape(-1, 6 if order == 2 else 3)
    named = {}
    for name, lines in curves.items():
        nodes = [gmsh.model.mesh.getNodes(1, line, includeBoundary=True)[0] for line in lines]
        named[name] = np.unique(place[np.concatenate(nodes).astype(np.int64)])
    return _Triangles(coordinates.reshape(-1, 3)[:, :2], elements, named)


def _reflect(half: _Triangles, tolerance: float) -> _Triangles:
    """`half` (x >= 0) with its mirror image, points on x = 0 shared."""
    points = half.points.copy()
    on_axis = np.abs(points[:, 0]) < tolerance
    points[on_axis, 0] = 0.0
    image = np.empty(len(points), dtype=np.int64)
    image[on_axis] = np.flatnonzero(on_axis)
    image[~on_axis] = len(points) + np.arange(np.count_nonzero(~on_axis))
    mirrored = image[half.elements][:, _REFLECTED[half.elements.shape[1]]]
    return _Triangles(
        np.vstack([points, points[~on_axis] * [-1.0, 1.0]]),
        np.vstack([half.elements, mirrored]),
        {name: np.union1d(nodes, image[nodes]) for name, nodes in half.named.items()},
    )


def _corners_first(body: _Triangles) -> _Triangles:
    """The same body, corners numbered before mid-side points: then scikit-fem leaves the numbers alone."""
    corners = np.unique(body.elements[:, :3])
    order = np.concatenate([corners, np.setdiff1d(np.arange(len(body.points)), corners)])
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    named = {name: place[nodes] for name, nodes in body.named.items()}
    return _Triangles(body.points[order], place[body.elements], named)


def _facets(mesh: skfem.MeshTri, nodes: Indices) -> Indices:
    """Boundary facets whose corners all belong to `nodes`."""
    facets = mesh.boundary_facets()
    inside = np.isin(mesh.facets[:, facets], nodes).all(axis=0)
    return facets[inside].astype(np.int64)
