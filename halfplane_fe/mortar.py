r"""Dual mortar coupling of two contact sides on their common refinement: flat or curved, matching or not.

Points of the two sides that lie above each other are compared along the normal n and the tangent t of the line half-way between
the sides, in the mean over the multipliers of the lower side:

    g_j = int psi_j n (X_u + u_u - X_l - u_l) / D_j,    s_j = int psi_j t (u_u - u_l) / D_j,    D_j = int psi_j = int phi_j

all of it along that line. phi and chi are the shape functions of the two sides, psi the dual basis of phi: int psi_j phi_k = D_j on
j = k, else 0. Dual multipliers make the lower side's part diagonal where it is flat, so that gap and traction stay nodal and the
contact law stays at the node; with phi they form a stable pair (Wohlmuth 2000; Popp and others 2012 for quadratic elements, whose
D_j are positive on a line). Both sides feel the same traction p n, q t: resultants are kept and a uniform pressure passes exactly.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Members = NDArray[np.intp]

# Points of a segment of the common refinement: exact for the product of two quadratics on a straight line, and to rounding for the
# slopes of a contact.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True, eq=False)
class Side:
    """One contact side in the common frame: a line y(x) of elements of order 1 or 2.

    Attributes
    ----------
    x, y : (n,) nodes in ascending order of x, mid-side nodes included, at the mean x of their element's ends [length]
    order : of the elements
    """

    x: Array
    y: Array
    order: int


@dataclass(frozen=True, eq=False)
class Mortar:
    """What takes displacements of the two sides to gap and slip at the n multipliers, and their tractions to nodal forces.

    Attributes
    ----------
    weights : (n,) D_j [length]
    normals : (2, n) weighted mean of n; the tangent is (n_y, -n_x)
    gap : (n,) weighted initial distance along n [length]
    nearest : x and distance where the sides are nearest to each other, of all points of integration [length]
    lower, upper : (2, n, 2, m) along the normal (0) or the tangent (1), multiplier, component (x, y), node of that side: the
        weighted mean of the displacement; transposed, the nodal forces of a multiplier's unit force
    """

    weights: Array
    normals: Array
    gap: Array
    nearest: tuple[float, float]
    lower: Array
    upper: Array


@dataclass(frozen=True)
class _Segment:
    """A piece of the common refinement: points, their share of the middle line, and what stands there."""

    element: int
    below: Members
    x: Array
    phi: Array
    above: Members
    chi: Array
    share: Array
    normal: Array  # (2, n_points), unit
    distance: Array


def mortar(lower: Side, upper: Side) -> Mortar:
    """Couple two sides that end above each other.

    Raises
    ------
    ValueError
        If they do not begin and end together.

    >>> line = lambda *x: Side(np.array(x), np.zeros(len(x)), order=1)
    >>> coupled = mortar(line(0.0, 0.5, 1.0), line(0.0, 0.3, 1.0))
    >>> (coupled.upper[0, :, 1] @ np.array([0.0, 0.3, 1.0])).round(12).tolist()  # linear functions pass
    [0.0, 0.5, 1.0]
    """
    segments = list(_segments(lower, upper))
    psi = _dual_bases(segments, lower.order + 1)
    n = len(lower.x)
    weights, normals, gap = np.zeros(n), np.zeros((2, n)), np.zeros(n)
    by_lower, by_upper = np.zeros((2, n, 2, n)), np.zeros((2, n, 2, len(upper.x)))
    for piece in segments:
        dual = psi[piece.element] @ piece.phi * piece.share
        weights[piece.below] += dual.sum(axis=1)
        gap[piece.below] += dual @ piece.distance
        nx, ny = piece.normal
        for component, (along_normal, along_tangent) in enumerate(((nx, ny), (ny, -nx))):
            normals[component, piece.below] += dual @ along_normal
            for direction, factor in enumerate((along_normal, along_tangent)):
                by_lower[direction, :, component][np.ix_(piece.below, piece.below)] += (dual * factor) @ piece.phi.T
                by_upper[direction, :, component][np.ix_(piece.below, piece.above)] += (dual * factor) @ piece.chi.T
    over = weights[:, None, None]
    x, distance = (np.concatenate([getattr(piece, name) for piece in segments]) for name in ("x", "distance"))
    least = int(np.argmin(distance))
    nearest = float(x[least]), float(distance[least])
    return Mortar(weights, normals / weights, gap / weights, nearest, by_lower / over, by_upper / over)


def _segments(lower: Side, upper: Side) -> Iterator[_Segment]:
    span = lower.x[-1] - lower.x[0]
    if max(abs(lower.x[0] - upper.x[0]), abs(lower.x[-1] - upper.x[-1])) > 1e-9 * span:
        raise ValueError("the two contact sides do not begin and end together")
    corners = np.union1d(lower.x[:: lower.order], upper.x[:: upper.order])
    corners = corners[np.concatenate([[True], np.diff(corners) > 1e-12 * span])]
    for begin, end in itertools.pairwise(corners):
        x = (begin + end) / 2 + (end - begin) / 2 * _POINTS
        below, phi, slope_below = _shape_functions(lower, x)
        above, chi, slope_above = _shape_functions(upper, x)
        slope = (slope_below + slope_above) / 2
        stretch = np.sqrt(1 + slope**2)
        normal = np.stack([-slope, np.ones_like(x)]) / stretch
        distance = (upper.y[above] @ chi - lower.y[below] @ phi) * normal[1]
        share = (end - begin) / 2 * _WEIGHTS * stretch
        yield _Segment(int(below[0]), below, x, phi, above, chi, share, normal, distance)


def _dual_bases(segments: list[_Segment], nodes: int) -> dict[int, Array]:
    """Matrix A with psi = A phi by element of the lower side: A = diag(int phi) (int phi phi^T)^-1."""
    mass: dict[int, Array] = {}
    for piece in segments:
        mass.setdefault(piece.element, np.zeros((nodes, nodes)))
        mass[piece.element] += (piece.phi * piece.share) @ piece.phi.T
    return {element: np.diag(matrix.sum(axis=1)) @ np.linalg.inv(matrix) for element, matrix in mass.items()}


def _shape_functions(side: Side, x: Array) -> tuple[Members, Array, Array]:
    """Nodes of the element that holds the points `x`, their shape functions there (order + 1, n_points), and the side's slope."""
    n_elements = (len(side.x) - 1) // side.order
    element = int(np.clip(np.searchsorted(side.x[:: side.order], x.mean()) - 1, 0, n_elements - 1))
    members = np.arange(element * side.order, (element + 1) * side.order + 1)
    values, slopes = _lagrange(side.x[members], x)
    return members, values, side.y[members] @ slopes


def _lagrange(nodes: Array, x: Array) -> tuple[Array, Array]:
    """Lagrange polynomials and their derivatives, each (n_nodes, n_points)."""
    values, slopes = np.ones((len(nodes), len(x))), np.zeros((len(nodes), len(x)))
    for j, own in enumerate(nodes):
        for other in np.delete(nodes, j):
            slopes[j] = (slopes[j] * (x - other) + values[j]) / (own - other)
            values[j] *= (x - other) / (own - other)
    return values, slopes
