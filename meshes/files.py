"""Field files, by meshio: kept in this one module, since meshio is hardly maintained."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray


def write_vtu(
    path: str | Path,
    points: NDArray[np.float64],
    cells: NDArray[np.int64],
    point_data: Mapping[str, NDArray[np.float64]],
) -> None:
    """Write one body with nodal fields as VTU.

    Parameters
    ----------
    path : file to write
    points : (n_points, 2) [length]
    cells : (n_elements, 3, 6, 4 or 9): corners, mid-side nodes, middle
    point_data : name -> (n_points,) or (n_points, k); vectors of two components get a third, 0
    """
    kind = {3: "triangle", 6: "triangle6", 4: "quad", 9: "quad9"}[cells.shape[1]]
    data = {name: _three_components(values) for name, values in point_data.items()}
    meshio.write_points_cells(path, _three_components(points), [(kind, cells)], point_data=data)


def _three_components(values: NDArray[np.float64]) -> NDArray[np.float64]:
    if values.ndim == 2 and values.shape[1] == 2:
        return np.column_stack([values, np.zeros(len(values))])
    return values
