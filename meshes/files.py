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
    """Write a meshed body, or the line of its surface, with its nodal fields as a VTU file for
    ParaView.

    Parameters
    ----------
    path
        file to write
    points
        (n_points, 2), x and y of the nodes [length]
    cells
        (n_elements, k), node numbers of each element: k = 2 for lines, 3 or 6 for triangles, 4 or 9
        for quadrilaterals; corners first, then mid-side nodes, then the middle
    point_data
        field name -> (n_points,) or (n_points, n_components); vectors of two components get a
        third, 0
    """
    cell_type = {2: "line", 3: "triangle", 6: "triangle6", 4: "quad", 9: "quad9"}[cells.shape[1]]
    # vectors with a third component 0, as VTU files have them
    nodal_fields = {name: _three_components(values) for name, values in point_data.items()}
    # Imported here: meshio loads a command line of its own, which only this needs.
    import meshio  # noqa: PLC0415

    meshio.write_points_cells(
        path, _three_components(points), [(cell_type, cells)], point_data=nodal_fields
    )


@dataclass(frozen=True)
class PvdEntry:
    """One field file of a PVD collection: instant `time`, number and name of its part (a body or
    a line of surface), and path `file` relative to the collection's folder.
    """

    time: float
    part: int
    name: str
    file: str


def write_pvd(path: str | Path, entries: Sequence[PvdEntry]) -> None:
    """Write a PVD file: the list by which ParaView opens the field files of all bodies and instants
    as one animation.

    Parameters
    ----------
    path
        file to write; the paths of the entries' files are relative to its folder
    entries
        for each field file its instant, the number and name of its part (a body or a line of
        surface), and its path
    """
    data_sets = [
        f"  <DataSet timestep={quoteattr(repr(entry.time))} part={quoteattr(str(entry.part))} "
        f"name={quoteattr(entry.name)} file={quoteattr(entry.file)}/>\n"
        for entry in entries
    ]
    xml_head = (
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"'
        ' byte_order="LittleEndian">\n <Collection>\n'
    )
    xml_end = " </Collection>\n</VTKFile>\n"
    Path(path).write_text(xml_head + "".join(data_sets) + xml_end, encoding="utf-8")


def _three_components(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (n, 2) with a third component, 0; all other values as they are."""
    if values.ndim == 2 and values.shape[1] == 2:
        return np.column_stack([values, np.zeros(len(values))])
    return values
