r"""Mortar coupling of two contact sides whose nodes do not match, on their common refinement.

Displacements u and v of the lower and upper side are compared in the mean, with multipliers on the lower side:

    gap_j = int psi_j (...) / D_j,    D_j = int psi_j = int phi_j,    so that v enters as Pi v,  Pi_jk = int psi_j chi_k / D_j

phi and chi are the shape functions of the two sides, psi the dual basis of phi: int psi_j phi_k = D_j on j = k, else 0. Dual
multipliers make the lower side's part diagonal, so that gap and traction stay nodal and the contact law stays at the node; with
phi they form a stable pair (Wohlmuth 2000; Popp and others 2012 for quadratic elements, whose D_j are positive on a line). Nodal
forces f on the lower side are -Pi^T f on the upper: resultant and moment are kept, and a uniform traction passes exactly.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Points of a segment of the common refinement: exact for the product of two quadratics.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


def mortar_projection(lower: Array, upper: Array, order: int) -> Array:
    """The matrix Pi (n_lower, n_upper) that takes nodal values of the upper side to weighted ones on the lower.

    Parameters
    ----------
    lower, upper : nodes of the two sides in ascending order, mid-side nodes included, both from the same end to the same end
    order : 1 or 2, of the elements of both sides

    Raises
    ------
    ValueError
        If the sides do not begin and end together.

    >>> pi = mortar_projection(np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.3, 1.0]), order=1)
    >>> (pi @ np.array([0.0, 0.3, 1.0])).round(12).tolist()  # linear functions pass
    [0.0, 0.5, 1.0]
    """
    span = lower[-1] - lower[0]
    if max(abs(lower[0] - upper[0]), abs(lower[-1] - upper[-1])) > 1e-9 * span:
        raise ValueError("the two contact sides do not begin and end together")
    corners = np.union1d(lower[::order], upper[::order])
    corners = corners[np.concatenate([[True], np.diff(corners) > 1e-12 * span])]
    coupling = np.zeros((len(lower), len(upper)))
    weights = np.zeros(len(lower))
    for begin, end in itertools.pairwise(corners):
        x = (begin + end) / 2 + (end - begin) / 2 * _POINTS
        dx = (end - begin) / 2 * _WEIGHTS
        below, phi = _shape_functions(lower, order, x)
        above, chi = _shape_functions(upper, order, x)
        psi = _dual(lower[below]) @ phi
        coupling[np.ix_(below, above)] += (psi * dx) @ chi.T
        weights[below] += psi @ dx
    return coupling / weights[:, None]


def _shape_functions(nodes: Array, order: int, x: Array) -> tuple[NDArray[np.intp], Array]:
    """Nodes of the element that holds the points `x`, and their shape functions there (order + 1, n_points)."""
    n_elements = (len(nodes) - 1) // order
    element = int(np.clip(np.searchsorted(nodes[::order], x.mean()) - 1, 0, n_elements - 1))
    members = np.arange(element * order, element * order + order + 1)
    return members, _lagrange(nodes[members], x)


def _lagrange(nodes: Array, x: Array) -> Array:
    """Lagrange polynomials (n_nodes, n_points)."""
    values = np.ones((len(nodes), len(x)))
    for j, own in enumerate(nodes):
        for other in np.delete(nodes, j):
            values[j] *= (x - other) / (own - other)
    return values


def _dual(nodes: Array) -> Array:
    """Matrix A of an element with psi = A phi: A = diag(int phi) (int phi phi^T)^-1."""
    half = (nodes[-1] - nodes[0]) / 2
    phi = _lagrange(nodes, nodes[0] + half * (1 + _POINTS))
    mass = (phi * _WEIGHTS * half) @ phi.T
    return np.diag(phi @ _WEIGHTS * half) @ np.linalg.inv(mass)
