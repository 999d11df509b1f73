"""Mirror-symmetric meshes by gmsh: the half x >= 0 of a body is meshed and reflected, so that
symmetry holds to the last bit.

Also measures of the quality of a mesh.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import gmsh
import numpy as np
import skfem
from numpy.typing import NDArray
from skfem.quadrature import get_quadrature

from meshes.bodies import Cells
from meshes.interrupts import interrupts_wait
from scenes.array_types import Array


def mesh_quality(mesh: skfem.Mesh, exact_area: float) -> dict[str, float]:
    """Measures of the quality of a mesh: numbers of elements and nodes, shape of the elements,
    error of the area.

    Parameters
    ----------
    mesh
        triangles or quadrilaterals of order 1 or 2
    exact_area
        area of the body that the mesh stands for [length^2]

    Returns
    -------
    dict
        elements, nodes; least_angle, of any corner [degrees]; worst_shape and mean_shape (1 for an
        equilateral triangle or a square, 0 for a sliver; from the corners); area_error (area of the
        curved elements over `exact_area`, minus 1); size_ratio (longest over shortest side of an
        element in the mesh).
    """
    # Sides of each element, as vectors at its corners, and the angles between them.
    is_triangular = mesh.refdom.nfacets == 3
    corners = mesh.p[:, mesh.t[: mesh.refdom.nfacets]]  # (2, corners, n_elements)
    side_ahead = np.roll(corners, -1, axis=1) - corners  # from each corner to the next one
    side_behind = np.roll(corners, 1, axis=1) - corners  # and to the one before
    side_lengths = np.linalg.norm(side_ahead, axis=0)
    cross_products = side_ahead[0] * side_behind[1] - side_ahead[1] * side_behind[0]
    angles = np.arctan2(np.abs(cross_products), np.sum(side_ahead * side_behind, axis=0))

    # Shape of each element, (n_elements,), and area by quadrature of the Jacobian determinant.
    shape_measures = (
        _triangle_shape(cross_products, side_lengths)
        if is_triangular
        else _quadrilateral_shape(side_ahead, side_behind, cross_products)
    )
    points, weights = get_quadrature(mesh.refdom, 4)
    area_of_mesh = (np.abs(mesh.mapping().detDF(points)) @ weights).sum()
    return {
        "elements": float(mesh.t.shape[1]),
        "nodes": float(mesh.p.shape[1]),
        "least_angle": float(np.degrees(angles.min())),
        "worst_shape": float(shape_measures.min()),
        "mean_shape": float(shape_measures.mean()),
        "area_error": float(area_of_mesh) / exact_area - 1,
        "size_ratio": float(side_lengths.max() / side_lengths.min()),
    }


def _triangle_shape(cross_products: Array, side_lengths: Array) -> Array:
    """Shape measure of triangles, (n_elements,), 1 for an equilateral one and 0 for a sliver:
    4 sqrt(3) area over the sum of the squared sides.

    `cross_products` (3, n_elements) of two sides each, of size twice the area; `side_lengths`
    (3, n_elements).
    """
    return np.asarray(2 * np.sqrt(3) * np.abs(cross_products[0]) / np.sum(side_lengths**2, axis=0))


def _quadrilateral_shape(side_ahead: Array, side_behind: Array, cross_products: Array) -> Array:
    """Shape measure of quadrilaterals, (n_elements,): 1 for a square, 0 for a sliver, negative for
    one that is not convex.

    It is the least over the corners of 2 a x b / (a^2 + b^2), a and b the two sides at a corner.

    Parameters
    ----------
    side_ahead, side_behind
        (2, 4, n_elements), vectors from each corner to the next and to the one before
    cross_products
        (4, n_elements), a x b of these vectors, signed
    """
    # +1 if the corners are numbered anticlockwise, else -1
    sense = np.sign(cross_products.sum(axis=0))
    squared_sides = np.sum(side_ahead**2, axis=0) + np.sum(side_behind**2, axis=0)
    return np.asarray((2 * sense * cross_products / squared_sides).min(axis=0))


Indices = NDArray[np.int64]

# Which node of an element stands at each position after a reflection, in gmsh's order: corners,
# mid-side nodes, middle. By number of nodes: triangles of order 1 and 2, quadrilaterals likewise.
_NODES_OF_MIRRORED = {
    3: [0, 2, 1],
    6: [0, 2, 1, 5, 4, 3],
    4: [0, 3, 2, 1],
    9: [0, 3, 2, 1, 7, 6, 5, 4, 8],
}
_MESH_CLASSES = {3: skfem.MeshTri, 6: skfem.MeshTri2, 4: skfem.MeshQuad, 9: skfem.MeshQuad2}
_AXIS_DISTANCE = 1e-9  # nodes nearer to x = 0 lie on it; lengths are of order one


@dataclass(frozen=True)
class _MeshArrays:
    """A mesh as arrays, before it becomes one of scikit-fem."""

    points: Array  # (n_points, 2), x and y of the nodes
    elements: Indices  # (n_elements, nodes of one), node numbers in gmsh's order, corners first
    boundary_nodes: dict[str, Indices]  # name of a boundary -> numbers of its nodes

    @property
    def corners_per_element(self) -> int:
        """Number of corners of an element: 3 of triangles, 4 of quadrilaterals."""
        return 3 if self.elements.shape[1] in (3, 6) else 4


def mirrored_mesh(
    draw: Callable[[], Mapping[str, list[int]]],
    size_formula: str,
    order: int,
    cells: Cells = "triangles",
    points_on_true_face: Callable[[Array, dict[str, Indices]], Array] | None = None,
) -> skfem.Mesh:
    """Mesh of a mirror-symmetric body: gmsh meshes its half x >= 0, which is then reflected in
    x = 0, so that the mesh is symmetric to the last bit.

    Parameters
    ----------
    draw
        function that draws the half into gmsh's current model (geo kernel, lengths near 1).
        It returns boundary name -> tags of its curves; curves without a name lie on the axis
    size_formula
        element size at a point (x, y), as a formula of gmsh's field MathEval. For quadrilaterals
        twice the size that is wanted: gmsh halves each element at the end
    order
        1 or 2, polynomial order of elements and geometry
    cells
        shape of the elements: "triangles" or "quadrilaterals"
    points_on_true_face
        function that moves nodes of the half onto the true face: from points (n, 2) and
        boundary name -> numbers of its nodes to points (n, 2). None: nodes stay where gmsh put them

    Returns
    -------
    skfem.Mesh
        MeshTri, MeshTri2, MeshQuad or MeshQuad2 with the named boundaries.
    """
    # Half the mesh: points, elements, and the nodes of each named boundary.
    half_mesh = _mesh_of_half(draw, size_formula, order, cells)
    if points_on_true_face is not None:
        half_mesh = _MeshArrays(
            points_on_true_face(half_mesh.points, half_mesh.boundary_nodes),
            half_mesh.elements,
            half_mesh.boundary_nodes,
        )

    # With its mirror image; corners have the first numbers, as scikit-fem keeps these.
    return _scikit_fem_mesh(_renumbered_corners_first(_with_mirror_image(half_mesh)), order)


def _scikit_fem_mesh(whole_mesh: _MeshArrays, order: int) -> skfem.Mesh:
    """Mesh of scikit-fem, with named boundaries, from the arrays of a mesh whose corners have the
    first numbers. It raises where the mesh is not valid.

    `whole_mesh` holds points (n, 2), the node numbers of each element (n_elements, k), corners
    first, and the nodes of each named boundary. `order` is 1 or 2, of elements and geometry.
    """
    transposed_points = np.ascontiguousarray(whole_mesh.points.T)
    transposed_elements = np.ascontiguousarray(whole_mesh.elements.T)

    # The mesh with straight sides is checked.
    corners_of_elements = transposed_elements[: whole_mesh.corners_per_element]
    n_corners = int(corners_of_elements.max()) + 1
    # _MESH_CLASSES: class of scikit-fem by the number of nodes of an element
    straight_mesh = _MESH_CLASSES[whole_mesh.corners_per_element](
        transposed_points[:, :n_corners].copy(), corners_of_elements.copy()
    )
    straight_mesh.is_valid(raise_=True)
    mesh = (
        _MESH_CLASSES[len(transposed_elements)](transposed_points, transposed_elements)
        if order == 2
        else straight_mesh
    )
    return mesh.with_boundaries(
        {name: _facets(mesh, nodes) for name, nodes in whole_mesh.boundary_nodes.items()}
    )


@contextmanager
def _gmsh_model(cells: Cells) -> Iterator[None]:
    """Context manager that opens gmsh with an empty model and options for triangles or
    quadrilaterals.

    gmsh prints no messages, raises on errors and gives the same mesh on every run. It has one
    global state, so it is closed on leaving, whatever happened.
    """
    handler_of_broken_pipe = (
        signal.getsignal(signal.SIGPIPE) if hasattr(signal, "SIGPIPE") else None
    )
    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    # gmsh lets a broken pipe end the whole process; in Python it is an error that can be reported.
    # Only the main thread may set handlers of signals.
    if handler_of_broken_pipe is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGPIPE, handler_of_broken_pipe)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.AbortOnError", 2)
        # The element size comes from a size field alone.
        for size_rule in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
            gmsh.option.setNumber(f"Mesh.MeshSize{size_rule}", 0)
        gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay
        gmsh.option.setNumber("Mesh.RandomSeed", 1)
        if cells == "quadrilaterals":
            gmsh.option.setNumber("Mesh.Algorithm", 8)  # frontal Delaunay for quadrilaterals
            gmsh.option.setNumber("Mesh.RecombineAll", 1)
            # no two sides of one element in line on the face
            gmsh.option.setNumber("Mesh.RecombineMinimumQuality", 0.1)
            # every element into quadrilaterals of half its size
            gmsh.option.setNumber("Mesh.SubdivisionAlgorithm", 1)
        gmsh.model.add("half")
        yield
    finally:
        gmsh.finalize()


def _mesh_of_half(
    draw: Callable[[], Mapping[str, list[int]]], size_formula: str, order: int, cells: Cells
) -> _MeshArrays:
    """Mesh half a body (x >= 0) with gmsh and read nodes, elements and boundary nodes back.

    Parameters
    ----------
    draw
        function that draws the half into gmsh's current model and returns boundary name -> tags of
        its curves
    size_formula
        element size as a formula of x and y, for gmsh's field MathEval
    order
        1 or 2, polynomial order of elements and geometry
    cells
        shape of the elements: "triangles" or "quadrilaterals"
    """
    # Ctrl-C waits, since gmsh's one global state has to be closed properly.
    with interrupts_wait(), _gmsh_model(cells):
        curves_by_name = draw()
        gmsh.model.geo.synchronize()
        size_field = gmsh.model.mesh.field.add("MathEval")
        gmsh.model.mesh.field.setString(size_field, "F", size_formula)
        gmsh.model.mesh.field.setAsBackgroundMesh(size_field)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        return _mesh_from_gmsh(curves_by_name)


def _mesh_from_gmsh(curves: Mapping[str, list[int]]) -> _MeshArrays:
    """Mesh in gmsh's current model: coordinates of the nodes, node numbers of the elements and of
    each named boundary.

    `curves` maps the name of a boundary to the gmsh tags of its curves. gmsh's tags of nodes may
    have gaps; here nodes are numbered from 0. ValueError where elements are of more than one kind.
    """
    # Points, and the number of the node with each tag.
    node_tags, coordinates, _ = gmsh.model.mesh.getNodes()
    node_of_tag = np.zeros(int(node_tags.max()) + 1, dtype=np.int64)
    node_of_tag[node_tags.astype(np.int64)] = np.arange(len(node_tags))

    # Elements of dimension 2: tags of their nodes in one row, element after element.
    element_types, element_tags, connectivity = gmsh.model.mesh.getElements(2)
    if len(element_types) != 1:
        raise ValueError("gmsh left elements of more than one kind")
    elements = node_of_tag[connectivity[0].astype(np.int64)].reshape(len(element_tags[0]), -1)

    boundary_nodes = {}
    for name, curve_tags in curves.items():
        node_tags_of_curves = [
            gmsh.model.mesh.getNodes(1, curve_tag, includeBoundary=True)[0]
            for curve_tag in curve_tags
        ]
        boundary_nodes[name] = np.unique(
            node_of_tag[np.concatenate(node_tags_of_curves).astype(np.int64)]
        )
    return _MeshArrays(coordinates.reshape(-1, 3)[:, :2], elements, boundary_nodes)


def _with_mirror_image(half_mesh: _MeshArrays) -> _MeshArrays:
    """Mesh of a whole body from that of its half x >= 0: the half and its mirror image in x = 0,
    which share the nodes on the axis.

    The nodes of mirrored elements are listed in another order (`_NODES_OF_MIRRORED`, by their
    number), so that their area stays positive. Nodes nearer to x = 0 than 1e-9 lie on the axis;
    the half-width of the finely meshed face is 1.
    """
    points_of_half = half_mesh.points.copy()
    is_on_axis = np.abs(points_of_half[:, 0]) < _AXIS_DISTANCE
    points_of_half[is_on_axis, 0] = 0.0
    # Number of each node's image: of one on the axis its own, of others a new one.
    mirror_image_of_node = np.empty(len(points_of_half), dtype=np.int64)
    mirror_image_of_node[is_on_axis] = np.flatnonzero(is_on_axis)
    mirror_image_of_node[~is_on_axis] = len(points_of_half) + np.arange(
        np.count_nonzero(~is_on_axis)
    )
    mirrored_elements = mirror_image_of_node[half_mesh.elements][
        :, _NODES_OF_MIRRORED[half_mesh.elements.shape[1]]
    ]
    return _MeshArrays(
        np.vstack([points_of_half, points_of_half[~is_on_axis] * [-1.0, 1.0]]),
        np.vstack([half_mesh.elements, mirrored_elements]),
        {
            name: np.union1d(nodes, mirror_image_of_node[nodes])
            for name, nodes in half_mesh.boundary_nodes.items()
        },
    )


def _renumbered_corners_first(mesh: _MeshArrays) -> _MeshArrays:
    """The mesh with its nodes renumbered: all corners of elements first, then mid-side and
    middle nodes, so that scikit-fem keeps these numbers. `elements` (n_elements, k) lists the node
    numbers of each element, corners first.

    Points that belong to no element are dropped, such as the centre of an arc, which gmsh lists
    among the nodes.
    """
    corner_nodes = np.unique(mesh.elements[:, : mesh.corners_per_element])
    nodes_in_order = np.concatenate([corner_nodes, np.setdiff1d(mesh.elements, corner_nodes)])
    new_number = np.full(len(mesh.points), -1)
    new_number[nodes_in_order] = np.arange(len(nodes_in_order))
    boundary_nodes = {name: new_number[nodes] for name, nodes in mesh.boundary_nodes.items()}
    return _MeshArrays(mesh.points[nodes_in_order], new_number[mesh.elements], boundary_nodes)


def _facets(mesh: skfem.Mesh, nodes: Indices) -> Indices:
    """Numbers of the element sides on the boundary of a mesh whose corners all belong to `nodes`
    (numbers of nodes).
    """
    facets = mesh.boundary_facets()
    is_on_named_boundary = np.isin(mesh.facets[:, facets], nodes).all(axis=0)
    return facets[is_on_named_boundary].astype(np.int64)
