"""Figures that say whether a mesh is fit for use."""

from __future__ import annotations

import numpy as np
import skfem


def mesh_quality(mesh: skfem.MeshTri, exact_area: float) -> dict[str, float]:
    """Counts, shape and area of a triangle mesh.

    Parameters
    ----------
    mesh : triangles of order 1 or 2
    exact_area : area of the body that the mesh stands for [length^2]

    Returns
    -------
    dict
        elements, nodes; least_angle [degrees]; worst_shape and mean_shape (4 sqrt(3) area / sum of squared sides: 1 for an
        equilateral triangle, 0 for a sliver; from the corners); area_error (relative, isoparametric);
        size_ratio (longest side over shortest side in the mesh).
    """
    corners = mesh.p[:, mesh.t[:3]]  # (2, 3, n_elements)
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=0)
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(one[0] * two[1] - one[1] * two[0]) / 2
    shape = 4 * np.sqrt(3) * area / np.sum(sides**2, axis=0)
    a, b, c = sides
    cosines = np.array([(b**2 + c**2 - a**2) / (2 * b * c), (c**2 + a**2 - b**2) / (2 * c * a), (a**2 + b**2 - c**2) / (2 * a * b)])
    basis = skfem.Basis(mesh, skfem.ElementTriP1(), intorder=4)
    meshed_area = float(basis.dx.sum())
    return {
        "elements": float(mesh.t.shape[1]),
        "nodes": float(mesh.p.shape[1]),
        "least_angle": float(np.degrees(np.arccos(np.clip(cosines, -1, 1)).min())),
        "worst_shape": float(shape.min()),
        "mean_shape": float(shape.mean()),
        "area_error": meshed_area / exact_area - 1,
        "size_ratio": float(sides.max() / sides.min()),
    }
