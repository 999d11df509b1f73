"""Figures that say whether a mesh is fit for use."""

from __future__ import annotations

import numpy as np
import skfem
from numpy.typing import NDArray

Array = NDArray[np.float64]


def mesh_quality(mesh: skfem.Mesh, exact_area: float) -> dict[str, float]:
    """Counts, shape and area of a mesh of triangles or of quadrilaterals.

    Parameters
    ----------
    mesh : triangles or quadrilaterals of order 1 or 2
    exact_area : area of the body that the mesh stands for [length^2]

    Returns
    -------
    dict
        elements, nodes; least_angle [degrees]; worst_shape and mean_shape (1 for an equilateral triangle or a square, 0 for a
        sliver; from the corners); area_error (relative, isoparametric); size_ratio (longest over shortest side in the mesh).
    """
    triangles = mesh.refdom.nfacets == 3
    corners = mesh.p[:, mesh.t[: mesh.refdom.nfacets]]  # (2, corners, n_elements)
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    sides = np.linalg.norm(ahead, axis=0)
    cross = ahead[0] * back[1] - ahead[1] * back[0]
    angles = np.arctan2(np.abs(cross), np.sum(ahead * back, axis=0))
    shape = _triangle_shape(cross, sides) if triangles else _quadrilateral_shape(ahead, back, cross)
    basis = skfem.Basis(mesh, skfem.ElementTriP1() if triangles else skfem.ElementQuad1(), intorder=4)
    return {
        "elements": float(mesh.t.shape[1]),
        "nodes": float(mesh.p.shape[1]),
        "least_angle": float(np.degrees(angles.min())),
        "worst_shape": float(shape.min()),
        "mean_shape": float(shape.mean()),
        "area_error": float(basis.dx.sum()) / exact_area - 1,
        "size_ratio": float(sides.max() / sides.min()),
    }


def _triangle_shape(cross: Array, sides: Array) -> Array:
    """4 sqrt(3) area over the sum of the squared sides."""
    return np.asarray(2 * np.sqrt(3) * np.abs(cross[0]) / np.sum(sides**2, axis=0))


def _quadrilateral_shape(ahead: Array, back: Array, cross: Array) -> Array:
    """Least over the corners of twice the parallelogram's area over the squares of its sides; negative if not convex."""
    sense = np.sign(cross.sum(axis=0))
    return np.asarray((2 * sense * cross / (np.sum(ahead**2, axis=0) + np.sum(back**2, axis=0))).min(axis=0))
