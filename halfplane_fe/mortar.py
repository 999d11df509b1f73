r"""Dual mortar coupling of two contact sides on their common refinement: flat or curved, matching
or not.

Points of the two sides that lie above each other are compared along the normal n and the tangent t
of the line half-way between the sides, in the mean over the multipliers of the lower side:

    g_j = int psi_j n (X_u + u_u - X_l - u_l) / D_j,    s_j = int psi_j t (u_u - u_l) / D_j,
    D_j = int psi_j = int phi_j

all of it along that line. phi and chi are the shape functions of the two sides, psi the dual basis
of phi: int psi_j phi_k = D_j on j = k, else 0. Dual multipliers make the lower side's part diagonal
where it is flat, so that gap and traction stay nodal and the contact law stays at the node; with
phi they form a stable pair (Wohlmuth 2000; Popp and others 2012 for quadratic elements, whose D_j
are positive on a line). Both sides feel the same traction p n, q t: resultants are kept and a
uniform pressure passes exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from scenes.array_types import Array, Indices

# Points of a segment of the common refinement: exact for the product of two quadratics on a
# straight line, and to rounding for the slopes of a contact.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True, eq=False)
class Side:
    """One contact side in the common frame: a line y(x) of elements of order 1 or 2.

    Attributes
    ----------
    x, y
        (n,) nodes in ascending order of x, mid-side nodes included, at the mean x of their
        element's ends [length]
    order
        of the elements
    """

    x: Array
    y: Array
    order: int


@dataclass(frozen=True, eq=False)
class Mortar:
    """Operators of the dual mortar coupling: from displacements of the two sides to gap and slip at
    the n multipliers, one of each node of the lower side, and from tractions to nodal forces.

    Attributes
    ----------
    face_lengths
        (n,) integrals D_j of the dual functions [length]
    face_normals
        (2, n) weighted mean of n; the tangent is (n_y, -n_x)
    gap
        (n,) weighted initial distance along n [length]
    nearest_x_and_gap
        x and distance where the sides are nearest to each other, of all points of integration
        [length]
    lower, upper
        (2, n, 2, m) along the normal (0) or the tangent (1), multiplier, component (x, y), node
        of that side: the weighted mean of the displacement; transposed, the nodal forces of a
        multiplier's unit force
    """

    face_lengths: Array
    face_normals: Array
    gap: Array
    nearest_x_and_gap: tuple[float, float]
    lower: Array
    upper: Array


def mortar(lower_face: Side, upper_face: Side) -> Mortar:
    """Dual mortar coupling of two contact faces: operators that give gap and slip at the n nodes of
    the lower face as weighted means of the displacements of both faces.

    Points above each other are compared along the unit normal N and tangent T of the line half-way
    between the faces. With psi_j the dual function (Lagrange multiplier) of node j of the lower
    face, and w_j = int psi_j:

        gap_j = int psi_j N (X_u + u_u - X_l - u_l) / w_j,   slip_j = int psi_j T (u_u - u_l) / w_j

    # notation: X places, u displacements, subscripts u, l of the upper and the lower face; in
    # subscripts of einsum s segments of the common refinement, m Gauss points of each, k, l nodes
    # of an element; s, m in sizes of arrays are their numbers

    Parameters
    ----------
    lower_face, upper_face
        nodes of the two faces in the common frame: x (n,) ascending, y, and the order 1 or 2 of
        their elements

    Returns
    -------
    Mortar
        Of each dual function its integral w_j, and weighted means: of the normal, of the distance
        along it, and of the displacements of either face; also where the faces are nearest.

    Raises
    ------
    ValueError
        If the faces do not begin and end at the same x.

    Examples
    --------
    >>> line = lambda *x: Side(np.array(x), np.zeros(len(x)), order=1)
    >>> coupled = mortar(line(0.0, 0.5, 1.0), line(0.0, 0.3, 1.0))
    >>> linear = np.array([0.0, 0.3, 1.0])  # linear functions pass
    >>> (coupled.upper[0, :, 1] @ linear).round(12).tolist()
    [0.0, 0.5, 1.0]
    """
    side_length = lower_face.x[-1] - lower_face.x[0]
    if (
        max(abs(lower_face.x[0] - upper_face.x[0]), abs(lower_face.x[-1] - upper_face.x[-1]))
        > 1e-9 * side_length
    ):
        raise ValueError("the two contact sides do not begin and end together")

    # Common refinement: segments between the ends of the elements of both faces, with Gauss points.
    segment_ends = np.union1d(lower_face.x[:: lower_face.order], upper_face.x[:: upper_face.order])
    segment_ends = segment_ends[
        np.concatenate([[True], np.diff(segment_ends) > 1e-12 * side_length])
    ]
    middle = (segment_ends[1:] + segment_ends[:-1])[:, None] / 2
    half_length = np.diff(segment_ends)[:, None] / 2
    # _POINTS: five Gauss points from -1 to 1; _WEIGHTS: their weights
    x = middle + half_length * _POINTS

    # Line half-way between the faces at these points, (s, m): its slope, normal and tangent.
    lower_at_points = _side_at_points(lower_face, x)
    upper_at_points = _side_at_points(upper_face, x)
    slope = (lower_at_points.slope + upper_at_points.slope) / 2  # of the line half-way between
    length_factor = np.sqrt(1 + slope**2)
    lengths = half_length * _WEIGHTS * length_factor  # Gauss weights, along that line
    unit_normal = np.stack([-slope, np.ones_like(x)]) / length_factor
    unit_tangent = np.stack([unit_normal[1], -unit_normal[0]])
    distance_along_normal = (upper_at_points.y - lower_at_points.y) * unit_normal[1]

    # Integrals of functions at the points times the dual functions.
    n_duals = len(lower_face.x)
    weighted_duals = _weighted_dual_functions(lower_face, lower_at_points, lengths)

    def integrals_with_duals(values: Array) -> Array:
        """Integrals (n,) of dual functions psi_j times a function given at the points (s, m)."""
        integrals = np.einsum("skm,sm->sk", weighted_duals, values)
        sums = np.bincount(lower_at_points.nodes.ravel(), integrals.ravel(), n_duals)
        return np.asarray(sums, dtype=np.float64)

    dual_integrals = integrals_with_duals(np.ones_like(x))

    def mean_displacement(side: Side, side_at_points: _SideAtPoints) -> Array:
        """Operator from displacements of the nodes of one face to their means along normal and
        tangent, weighted by each dual function: (2, n, 2, n_nodes), normal or tangent, dual
        function, x or y, node of the face.
        """
        operator = np.zeros((2, n_duals, 2, len(side.x)))
        for direction, vector in enumerate((unit_normal, unit_tangent)):
            for xy, vector_component in enumerate(vector):
                integrals = np.einsum(
                    "skm,sm,slm->skl", weighted_duals, vector_component, side_at_points.shapes
                )
                np.add.at(
                    operator[direction, :, xy],
                    (lower_at_points.nodes[:, :, None], side_at_points.nodes[:, None, :]),
                    integrals / dual_integrals[lower_at_points.nodes][:, :, None],
                )
        return operator

    nearest_point = np.unravel_index(np.argmin(distance_along_normal), distance_along_normal.shape)
    return Mortar(
        face_lengths=dual_integrals,
        face_normals=np.stack([integrals_with_duals(component) for component in unit_normal])
        / dual_integrals,
        gap=integrals_with_duals(distance_along_normal) / dual_integrals,
        nearest_x_and_gap=(float(x[nearest_point]), float(distance_along_normal[nearest_point])),
        lower=mean_displacement(lower_face, lower_at_points),
        upper=mean_displacement(upper_face, upper_at_points),
    )


def _weighted_dual_functions(side: Side, side_at_points: _SideAtPoints, lengths: Array) -> Array:
    """Dual shape functions of the elements of a contact face at Gauss points, times the weight of
    each point in integrals: (s, k, m) at m points of s segments, of the k nodes of an element.

        psi = diag(int phi) (int phi phi^T)^-1 phi,   so that int psi_j phi_k = 0 for j not k

    # notation: phi shape functions of an element, psi their dual functions

    Parameters
    ----------
    side, side_at_points
        the face with its elements of order 1 or 2, and at the points of each segment the shape
        functions and node numbers of the element that it lies in
    lengths
        (s, m) Gauss weight of each point, along the line half-way between the faces [length]
    """
    phi = side_at_points.shapes  # (s, k, m)
    element = side_at_points.nodes[:, 0] // side.order  # number of that of each segment
    n_elements = (len(side.x) - 1) // side.order
    mass_matrices = np.zeros((n_elements, side.order + 1, side.order + 1))
    np.add.at(mass_matrices, element, np.einsum("skm,sm,slm->skl", phi, lengths, phi))
    dual_matrices = mass_matrices.sum(axis=2)[:, :, None] * np.linalg.inv(mass_matrices)
    return np.asarray(np.einsum("skl,slm,sm->skm", dual_matrices[element], phi, lengths))


class _SideAtPoints(NamedTuple):
    """Shape of a side at m points of each of s segments.

    Attributes
    ----------
    nodes
        (s, k) numbers of the k nodes of the element that holds the segment
    shapes
        (s, k, m) their shape functions at the points
    y, slope
        (s, m) y and dy/dx of the side at the points
    """

    nodes: Indices
    shapes: Array
    y: Array
    slope: Array


def _side_at_points(side: Side, x: Array) -> _SideAtPoints:
    """Shape functions, height y and slope dy/dx of a contact face at abscissae `x` (s, m): m points
    of each of s segments, each segment within one element of the face.

    `side` is the face: x and y (n,) of its nodes, ascending in x, and the order 1 or 2 of its
    elements.

    # notation: in subscripts of einsum s segments, k nodes of an element, m points
    """
    # Element of each segment, by the mean of its points, and x (s, k, 1) of its nodes.
    element_ends = side.x[:: side.order]
    element = np.clip(np.searchsorted(element_ends, x.mean(axis=1)) - 1, 0, len(element_ends) - 2)
    nodes = element[:, None] * side.order + np.arange(side.order + 1)
    x_of_nodes = side.x[nodes][:, :, None]
    shape_functions = np.ones((*nodes.shape, x.shape[1]))
    slopes_of_functions = np.zeros((*nodes.shape, x.shape[1]))
    # Lagrange polynomials and their derivatives, by the product rule for each further factor.
    for j in range(side.order + 1):
        for k in range(side.order + 1):
            if k == j:
                continue
            distance = x_of_nodes[:, j] - x_of_nodes[:, k]
            slope_before = slopes_of_functions[:, j]
            slopes_of_functions[:, j] = (
                slope_before * (x - x_of_nodes[:, k]) + shape_functions[:, j]
            ) / distance
            shape_functions[:, j] *= (x - x_of_nodes[:, k]) / distance
    y = np.einsum("sk,skm->sm", side.y[nodes], shape_functions)
    slope = np.einsum("sk,skm->sm", side.y[nodes], slopes_of_functions)
    return _SideAtPoints(nodes, shape_functions, y, slope)
