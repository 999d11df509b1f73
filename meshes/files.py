"""Field files written, VTU by meshio and their collection PVD; meshio, hardly maintained, is kept
here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray


def write_vtu(
    path: str | Path,
    points: NDArray[np.float64],
    cells: NDArray[np.int64],
    point_data: Mapping[str, NDArray[np.float64]],
) -> None:
    """Write one body, or the line of its surface, with nodal fields as VTU.

    Parameters
    ----------
    path
        file to write
    points
        (n_points, 2) [length]
    cells
        (n_elements, 3, 6, 4 or 9): corners, mid-side nodes, middle; (n_elements, 2) for lines
    point_data
        name -> (n_points,) or (n_points, k); vectors of two components get a third, 0
    """
    kind = {2: "line", 3: "triangle", 6: "triangle6", 4: "quad", 9: "quad9"}[cells.shape[1]]
    data = {name: _three_components(values) for name, values in point_data.items()}
    import meshio  # noqa: PLC0415 - and with it a command line of its own, where files are written

    meshio.write_points_cells(path, _three_components(points), [(kind, cells)], point_data=data)


@dataclass(frozen=True)
class PvdEntry:
    """One file of a collection: when it holds, which part of the whole it is, where it lies beside
    the collection.
    """

    time: float
    part: int
    name: str
    file: str


def write_pvd(path: str | Path, entries: Sequence[PvdEntry]) -> None:
    """Write a PVD collection: the field files of all parts and instants as one, with the values of
    time, for ParaView.

    Parameters
    ----------
    path
        file to write, in the folder that the entries' files lie in or above it
    """
    lines = [
        f"  <DataSet timestep={quoteattr(repr(entry.time))} part={quoteattr(str(entry.part))} "
        f"name={quoteattr(entry.name)} file={quoteattr(entry.file)}/>\n"
        for entry in entries
    ]
    head = (
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"'
        ' byte_order="LittleEndian">\n <Collection>\n'
    )
    Path(path).write_text(head + "".join(lines) + " </Collection>\n</VTKFile>\n", encoding="utf-8")


def _three_components(values: NDArray[np.float64]) -> NDArray[np.float64]:
    if values.ndim == 2 and values.shape[1] == 2:
        return np.column_stack([values, np.zeros(len(values))])
    return values
