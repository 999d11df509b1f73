r"""Dual mortar coupling of two contact faces on their common refinement: flat or curved, matching
or not.

Points of the two faces that lie above each other are compared along the normal n and the tangent t
of the line half-way between the faces, in the mean over the multipliers of the lower face:

    g_j = int psi_j n (X_u + u_u - X_l - u_l) / D_j,    s_j = int psi_j t (u_u - u_l) / D_j,
    D_j = int psi_j = int phi_j

all of it along that line. phi and chi are the shape functions of the two faces, psi the dual basis
of phi: int psi_j phi_k = D_j on j = k, else 0. Dual multipliers make the lower face's part diagonal
where it is flat, so that gap and traction stay nodal and the contact law stays at the node; with
phi they form a stable pair (Wohlmuth 2000; Popp and others 2012 for quadratic elements, whose D_j
are positive on a line). Both faces feel the same traction p n, q t: resultants are kept and a
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
class Face:
    """One contact face in the common frame: a line y(x) of elements of order 1 or 2.

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
    """Operators of the dual mortar coupling: from displacements of the two faces to gap and slip at
    the n multipliers, one of each node of the lower face, and from tractions to nodal forces.

    Attributes
    ----------
    face_lengths
        (n,) integrals D_j of the dual functions [length]
    face_normals
        (2, n) weighted mean of n; the tangent is (n_y, -n_x)
    gap
        (n,) weighted initial distance along n [length]
    nearest_x_and_gap
        x and distance where the faces are nearest to each other, of all points of integration
        [length]
    lower, upper
        (2, n, 2, m) along the normal (0) or the tangent (1), multiplier, component (x, y), node
        of that face: the weighted mean of the displacement; transposed, the nodal forces of a
        multiplier's unit force
    """

    face_lengths: Array
    face_normals: Array
    gap: Array
    nearest_x_and_gap: tuple[float, float]
    lower: Array
    upper: Array


def mortar(lower_face: Face, upper_face: Face) -> Mortar:
    """Dual mortar coupling of two contact faces whose nodes do not match: gap and slip at the n
    nodes of the lower face, as weighted means of the displacements of both faces.

    The weights psi_j are dual functions (Lagrange multipliers): the integral of psi_j times the
    shape function of another node k of the lower face is 0. So each node has a gap, a slip and
    forces of its own. With w_j = int psi_j, and N and T the unit normal and tangent of the line
    half-way between the faces:

        gap_j = int psi_j N (X_u + u_u - X_l - u_l) / w_j,   slip_j = int psi_j T (u_u - u_l) / w_j

    The integrals are sums over Gauss points of the segments between the ends of the elements of
    either face; both faces are taken at the same x.

    # notation: X places, u displacements, subscripts u, l of the upper and the lower face

    Parameters
    ----------
    lower_face, upper_face
        nodes of the two faces in the common frame: x (n,) ascending, y, and the order 1 or 2 of
        their elements

    Returns
    -------
    Mortar
        For each node of the lower face w_j, and means weighted by psi_j: of the normal, of the
        distance of the faces along it, and operators for those of the displacements of either face.
        Also the x and the distance where the faces are nearest.

    Raises
    ------
    ValueError
        If the faces do not begin and end at the same x.

    Examples
    --------
    >>> line = lambda *x: Face(np.array(x), np.zeros(len(x)), order=1)
    >>> coupled = mortar(line(0.0, 0.5, 1.0), line(0.0, 0.3, 1.0))
    >>> linear = np.array([0.0, 0.3, 1.0])  # linear functions pass
    >>> (coupled.upper[0, :, 1] @ linear).round(12).tolist()
    [0.0, 0.5, 1.0]
    """
    x_of_points, weights_along_x = _points_of_refinement(lower_face, upper_face)
    lower_at_points = _face_at_points(lower_face, x_of_points)
    upper_at_points = _face_at_points(upper_face, x_of_points)
    line = _line_half_way(lower_at_points, upper_at_points, weights_along_x)
    # `integrals_with`: integral of each psi_j times a function that is given at the points
    duals = _DualFunctions.of_face(lower_face, lower_at_points, line.weights)
    dual_integrals = duals.integrals_with(np.ones_like(x_of_points))  # w_j
    normal_integrals = [duals.integrals_with(component) for component in line.unit_normal]
    directions = np.stack([line.unit_normal, line.unit_tangent])
    nearest_point = np.unravel_index(np.argmin(line.distance), x_of_points.shape)
    return Mortar(
        face_lengths=dual_integrals,
        face_normals=np.stack(normal_integrals) / dual_integrals,
        gap=duals.integrals_with(line.distance) / dual_integrals,
        nearest_x_and_gap=(float(x_of_points[nearest_point]), float(line.distance[nearest_point])),
        lower=duals.mean_displacement(lower_at_points, len(lower_face.x), directions),
        upper=duals.mean_displacement(upper_at_points, len(upper_face.x), directions),
    )


def _points_of_refinement(lower_face: Face, upper_face: Face) -> tuple[Array, Array]:
    """Gauss points of the common refinement of two contact faces, five in each of its s segments.
    Returned are their abscissae x (s, 5) and the weight (s, 5) of each in integrals over x
    [length].

    The segments lie between the ends of the elements of both faces. Raises ValueError if the faces
    do not begin and end at the same x.
    """
    face_length = lower_face.x[-1] - lower_face.x[0]
    if (
        max(abs(lower_face.x[0] - upper_face.x[0]), abs(lower_face.x[-1] - upper_face.x[-1]))
        > 1e-9 * face_length
    ):
        raise ValueError("the two contact faces do not begin and end together")
    segment_ends = np.union1d(lower_face.x[:: lower_face.order], upper_face.x[:: upper_face.order])
    # ends closer than round-off are one
    is_new_end = np.concatenate([[True], np.diff(segment_ends) > 1e-12 * face_length])
    segment_ends = segment_ends[is_new_end]
    middles = (segment_ends[1:] + segment_ends[:-1])[:, None] / 2
    half_lengths = np.diff(segment_ends)[:, None] / 2
    # _POINTS: five Gauss points from -1 to 1; _WEIGHTS: their weights
    return middles + half_lengths * _POINTS, half_lengths * _WEIGHTS


class _LineHalfWay(NamedTuple):
    """Line half-way between two contact faces, at m points of each of s segments.

    Attributes
    ----------
    weights
        (s, m) weight of each point in integrals along the line [length]
    unit_normal, unit_tangent
        (2, s, m) x and y components of the normal N, out of the lower body, and the tangent T
    distance
        (s, m) from the lower face to the upper one along N [length]
    """

    weights: Array
    unit_normal: Array
    unit_tangent: Array
    distance: Array


def _line_half_way(
    lower_at_points: _FaceAtPoints, upper_at_points: _FaceAtPoints, weights_along_x: Array
) -> _LineHalfWay:
    """Line half-way between two contact faces: normal, tangent, and distance of the faces at points
    that lie above each other.

    `lower_at_points` and `upper_at_points` hold height y and slope dy/dx (s, m) of the faces at
    these points, `weights_along_x` (s, m) the weights of the points in integrals over x [length].
    """
    mean_slope = (lower_at_points.slope + upper_at_points.slope) / 2
    length_factor = np.sqrt(1 + mean_slope**2)  # length along the line over that along x
    unit_normal = np.stack([-mean_slope, np.ones_like(mean_slope)]) / length_factor
    return _LineHalfWay(
        weights=weights_along_x * length_factor,
        unit_normal=unit_normal,
        unit_tangent=np.stack([unit_normal[1], -unit_normal[0]]),
        distance=(upper_at_points.y - lower_at_points.y) * unit_normal[1],
    )


class _DualFunctions(NamedTuple):
    """Dual shape functions (Lagrange multipliers) of the n nodes of a contact face, at m points of
    each of s segments.

    Attributes
    ----------
    weighted_values
        (s, k, m) the dual functions of the k nodes of the element that holds the segment, times the
        weight of each point in integrals along the line half-way between the faces
    nodes
        (s, k) numbers of these nodes
    n_nodes
        number n of the nodes of the face
    """

    weighted_values: Array
    nodes: Indices
    n_nodes: int

    @classmethod
    def of_face(
        cls, face: Face, face_at_points: _FaceAtPoints, weights_along_line: Array
    ) -> _DualFunctions:
        """Dual functions of the nodes of a face, from its shape functions at the points.
        `weights_along_line` (s, m) are the weights of the points in integrals along the line
        half-way between the faces.
        """
        weighted_values = _weighted_dual_functions(face, face_at_points, weights_along_line)
        return cls(weighted_values, face_at_points.nodes, len(face.x))

    def integrals_with(self, values: Array) -> Array:
        """Integrals (n,) of each dual function times a function given at the points (s, m).

        # notation: in subscripts of einsum s segments, m points, k nodes of an element
        """
        integrals = np.einsum("skm,sm->sk", self.weighted_values, values)
        sums = np.bincount(self.nodes.ravel(), integrals.ravel(), self.n_nodes)
        return np.asarray(sums, dtype=np.float64)

    def mean_displacement(
        self, face_at_points: _FaceAtPoints, n_face_nodes: int, directions: Array
    ) -> Array:
        """Operator from displacements of the nodes of either face to their means along normal and
        tangent, weighted by each dual function. Its axes (2, n, 2, n_face_nodes) are normal or
        tangent, dual function, x or y, node of that face.

        Parameters
        ----------
        face_at_points
            shape functions and node numbers of that face at the points
        n_face_nodes
            number of its nodes
        directions
            (2, 2, s, m) unit normal and unit tangent, each by x and y, at the points

        # notation: in subscripts of einsum s segments, m points, k, l nodes of an element
        """
        dual_integrals = self.integrals_with(np.ones(directions.shape[2:]))
        operator = np.zeros((2, self.n_nodes, 2, n_face_nodes))
        for direction_number, unit_vector in enumerate(directions):
            for axis_number, component in enumerate(unit_vector):
                # by segment, dual function and node of that face
                integrals = np.einsum(
                    "skm,sm,slm->skl", self.weighted_values, component, face_at_points.shapes
                )
                np.add.at(
                    operator[direction_number, :, axis_number],
                    (self.nodes[:, :, None], face_at_points.nodes[:, None, :]),
                    integrals / dual_integrals[self.nodes][:, :, None],
                )
        return operator


def _weighted_dual_functions(
    face: Face, face_at_points: _FaceAtPoints, weights_along_line: Array
) -> Array:
    """Dual shape functions of the elements of a contact face at Gauss points, times the weight of
    each point in integrals. (s, k, m): at m points of s segments, of the k nodes of the element
    that holds the segment.

        psi = diag(int phi) (int phi phi^T)^-1 phi,   so that int psi_j phi_k = 0 for j not k

    # notation: phi shape functions of an element, psi their dual functions

    Parameters
    ----------
    face, face_at_points
        the face with its elements of order 1 or 2; and for each segment the element that it lies
        in: its node numbers, and its shape functions at the points
    weights_along_line
        (s, m) Gauss weight of each point, along the line half-way between the faces [length]
    """
    phi = face_at_points.shapes  # (s, k, m)
    element_of_segment = face_at_points.nodes[:, 0] // face.order  # its number
    n_elements = (len(face.x) - 1) // face.order
    mass_matrices = np.zeros((n_elements, face.order + 1, face.order + 1))
    np.add.at(
        mass_matrices,
        element_of_segment,
        np.einsum("skm,sm,slm->skl", phi, weights_along_line, phi),
    )
    dual_matrices = mass_matrices.sum(axis=2)[:, :, None] * np.linalg.inv(mass_matrices)
    return np.asarray(
        np.einsum("skl,slm,sm->skm", dual_matrices[element_of_segment], phi, weights_along_line)
    )


class _FaceAtPoints(NamedTuple):
    """Shape of a contact face at m points of each of s segments.

    Attributes
    ----------
    nodes
        (s, k) numbers of the k nodes of the element that holds the segment
    shapes
        (s, k, m) their shape functions at the points
    y, slope
        (s, m) y and dy/dx of the face at the points
    """

    nodes: Indices
    shapes: Array
    y: Array
    slope: Array


def _face_at_points(face: Face, x: Array) -> _FaceAtPoints:
    """Shape functions, height y and slope dy/dx of a contact face at abscissae `x` (s, m): m points
    of each of s segments, each segment within one element of the face.

    `face` is given by x and y (n,) of its nodes, ascending in x, and the order 1 or 2 of its
    elements.

    # notation: in subscripts of einsum s segments, k nodes of an element, m points
    """
    # Element of each segment, by the mean of its points, and x (s, k, 1) of its nodes.
    element_ends = face.x[:: face.order]
    element_numbers = np.clip(
        np.searchsorted(element_ends, x.mean(axis=1)) - 1, 0, len(element_ends) - 2
    )
    nodes = element_numbers[:, None] * face.order + np.arange(face.order + 1)
    x_of_nodes = face.x[nodes][:, :, None]
    shape_functions = np.ones((*nodes.shape, x.shape[1]))
    slopes_of_shapes = np.zeros((*nodes.shape, x.shape[1]))
    # Lagrange polynomials and their derivatives, by the product rule for each further factor.
    for j in range(face.order + 1):
        for k in range(face.order + 1):
            if k == j:
                continue
            x_difference = x_of_nodes[:, j] - x_of_nodes[:, k]
            slope_before = slopes_of_shapes[:, j]
            slopes_of_shapes[:, j] = (
                slope_before * (x - x_of_nodes[:, k]) + shape_functions[:, j]
            ) / x_difference
            shape_functions[:, j] *= (x - x_of_nodes[:, k]) / x_difference
    y_at_points = np.einsum("sk,skm->sm", face.y[nodes], shape_functions)
    slope_at_points = np.einsum("sk,skm->sm", face.y[nodes], slopes_of_shapes)
    return _FaceAtPoints(nodes, shape_functions, y_at_points, slope_at_points)
