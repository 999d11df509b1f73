"""Element sizes along the contact side and around it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshes.bodies import SurfaceGrading

Array = NDArray[np.float64]


def rounded(values: ArrayLike) -> Array:
    """Lengths to twelve digits, any shape: on the last digit gmsh makes another mesh, and the answer would depend on the units."""
    return np.vectorize(lambda value: float(f"{value:.12g}"), otypes=[float])(values)


def scaled_grading(grading: SurfaceGrading, factor: float) -> SurfaceGrading:
    """The grading in other units of length, rounded."""
    values = np.array([grading.inner, grading.outer, grading.size, grading.edge_size, grading.radius])
    return SurfaceGrading(*rounded(values * factor).tolist())


def surface_points(grading: SurfaceGrading) -> Array:
    """Corner points of the surface elements on 0 <= x <= outer: even on either side of `inner`."""
    inside = np.linspace(0, grading.inner, max(round(grading.inner / grading.size), 1) + 1 if grading.inner > 0 else 1)
    outside = np.linspace(grading.inner, grading.outer, max(round((grading.outer - grading.inner) / grading.edge_size), 1) + 1)
    return np.concatenate([inside[:-1], outside])


def size_field(grading: SurfaceGrading, growth: float) -> Callable[[float, float], float]:
    """Element size at a point: that of the nearest surface elements, growing with the distance."""

    def size(x: float, y: float) -> float:
        from_edges = np.hypot(max(abs(x) - grading.outer, grading.inner - abs(x), 0.0), y)
        from_middle = np.hypot(max(abs(x) - grading.inner, 0.0), y)
        fine = grading.edge_size + growth * float(from_edges)
        return min(fine, grading.size + growth * float(from_middle)) if grading.inner > 0 else fine

    return size
