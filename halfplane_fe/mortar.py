r"""Dual mortar coupling of two contact sides on their common refinement: flat or curved, matching
or not.

Points of the two sides that lie above each other are compared along the normal n and the tangent t
of the line half-way between the sides, in the mean over the multipliers of the lower side:

    g_j = int psi_j n (X_u + u_u - X_l - u_l) / D_j,    s_j = int psi_j t (u_u - u_l) / D_j,    D_j = int psi_j = int phi_j

all of it along that line. phi and chi are the shape functions of the two sides, psi the dual basis
of phi: int psi_j phi_k = D_j on j = k, else 0. Dual multipliers make the lower side's part diagonal
where it is flat, so that gap and traction stay nodal and the contact law stays at the node; with
phi they form a stable pair (Wohlmuth 2000; Popp and others 2012 for quadratic elements, whose D_j
are positive on a line). Both sides feel the same traction p n, q t: resultants are kept and a
uniform pressure passes exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from halfplane_fe.arrays import Array, Indices

# Points of a segment of the common refinement: exact for the product of two quadratics on a
# straight line, and to rounding for the slopes of a contact.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True, eq=False)
class Side:
    """One contact side in the common frame: a line y(x) of elements of order 1 or 2.

    Attributes
    ----------
    x, y : (n,) nodes in ascending order of x, mid-side nodes included, at the mean x of their
    element's ends [length] order : of the elements
    """

    x: Array
    y: Array
    order: int


@dataclass(frozen=True, eq=False)
class Mortar:
    """What takes displacements of the two sides to gap and slip at the n multipliers, and their
    tractions to nodal forces.

    Attributes
    ----------
    weights : (n,) D_j [length]
    normals : (2, n) weighted mean of n; the tangent is (n_y, -n_x)
    gap : (n,) weighted initial distance along n [length]
    nearest : x and distance where the sides are nearest to each other, of all points of integration
    [length] lower, upper : (2, n, 2, m) along the normal (0) or the tangent (1), multiplier,
    component (x, y), node of that side: the
        weighted mean of the displacement; transposed, the nodal forces of a multiplier's unit force
    """

    weights: Array
    normals: Array
    gap: Array
    nearest: tuple[float, float]
    lower: Array
    upper: Array


def mortar(lower: Side, upper: Side) -> Mortar:
    """Couple two sides that end above each other.

    Raises
    ------
    ValueError
        If they do not begin and end together.

    >>> line = lambda *x: Side(np.array(x), np.zeros(len(x)), order=1)
    >>> coupled = mortar(line(0.0, 0.5, 1.0), line(0.0, 0.3, 1.0))
    >>> (coupled.upper[0, :, 1] @ np.array([0.0, 0.3, 1.0])).round(
    ...     12
    ... ).tolist()  # linear functions pass
    [0.0, 0.5, 1.0]
    """
    # notation: k nodes of an element, s segments of the common refinement, m points of each
    span = lower.x[-1] - lower.x[0]
    if max(abs(lower.x[0] - upper.x[0]), abs(lower.x[-1] - upper.x[-1])) > 1e-9 * span:
        raise ValueError("the two contact sides do not begin and end together")
    corners = np.union1d(lower.x[:: lower.order], upper.x[:: upper.order])
    corners = corners[np.concatenate([[True], np.diff(corners) > 1e-12 * span])]
    middle, half = (corners[1:] + corners[:-1])[:, None] / 2, np.diff(corners)[:, None] / 2
    x = middle + half * _POINTS
    below, phi, y_below, slope_below = _on_side(lower, x)
    above, chi, y_above, slope_above = _on_side(upper, x)
    slope = (slope_below + slope_above) / 2
    stretch = np.sqrt(1 + slope**2)
    share, normal = half * _WEIGHTS * stretch, np.stack([-slope, np.ones_like(x)]) / stretch
    distance = (y_above - y_below) * normal[1]
    element, n = below[:, 0] // lower.order, len(lower.x)
    mass = np.zeros(((n - 1) // lower.order, lower.order + 1, lower.order + 1))
    np.add.at(mass, element, np.einsum("skm,sm,slm->skl", phi, share, phi))
    # psi = diag(int phi) (int phi phi^T)^-1 phi, element by element of the lower side.
    dual = np.einsum(
        "skl,slm,sm->skm", (mass.sum(axis=2)[:, :, None] * np.linalg.inv(mass))[element], phi, share
    )

    def at_nodes(values: Array) -> Array:
        return np.asarray(
            np.bincount(below.ravel(), np.einsum("skm,sm->sk", dual, values).ravel(), n),
            dtype=np.float64,
        )

    weights = at_nodes(np.ones_like(x))
    by_lower, by_upper = np.zeros((2, n, 2, n)), np.zeros((2, n, 2, len(upper.x)))
    for direction, along in enumerate((normal, np.stack([normal[1], -normal[0]]))):
        for component, factor in enumerate(along):
            for operator, nodes, shape in ((by_lower, below, phi), (by_upper, above, chi)):
                block = (
                    np.einsum("skm,sm,slm->skl", dual, factor, shape) / weights[below][:, :, None]
                )
                np.add.at(
                    operator[direction, :, component], (below[:, :, None], nodes[:, None, :]), block
                )
    least = np.unravel_index(np.argmin(distance), distance.shape)
    normals = np.stack([at_nodes(one) for one in normal]) / weights
    return Mortar(
        weights,
        normals,
        at_nodes(distance) / weights,
        (float(x[least]), float(distance[least])),
        by_lower,
        by_upper,
    )


def _on_side(side: Side, x: Array) -> tuple[Indices, Array, Array, Array]:
    """Nodes (s, k) of the elements that hold the segments with points `x` (s, m), shape functions
    (s, k, m), y and slope (s, m).
    """
    element = np.clip(
        np.searchsorted(side.x[:: side.order], x.mean(axis=1)) - 1,
        0,
        (len(side.x) - 1) // side.order - 1,
    )
    members = element[:, None] * side.order + np.arange(side.order + 1)
    nodes = side.x[members][:, :, None]
    values, slopes = np.ones((*members.shape, x.shape[1])), np.zeros((*members.shape, x.shape[1]))
    for j in range(side.order + 1):  # Lagrange polynomials and their derivatives
        for other in (k for k in range(side.order + 1) if k != j):
            apart = nodes[:, j] - nodes[:, other]
            slopes[:, j] = (slopes[:, j] * (x - nodes[:, other]) + values[:, j]) / apart
            values[:, j] *= (x - nodes[:, other]) / apart
    y, slope = (np.einsum("sk,skm->sm", side.y[members], shape) for shape in (values, slopes))
    return members, values, y, slope
