"""VTU and legacy VTK files by VTK's readers, in a process of its own: VTK ends or hangs the process
on some broken files.

    python vtk_files.py BYTES SECONDS      the most memory and processor time; paths as a JSON list
                                           on stdin

Writes the arrays of all files as npz to stdout. On stderr stands {"file": number} before each file,
and {"file": number, "reason": text} for one that can't be read, with exit code 1.
`reports.scoring.field_files` starts it; nothing of this project is imported here, and of VTK only
the readers, so that it starts in a second.
"""

from __future__ import annotations

import io
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_LARGEST_COORDINATE = 1e100  # the square of a larger coordinate would be none


def arrays_of(path: Path) -> dict[str, NDArray[Any]]:
    """Mesh and fields of a .vtu or .vtk file, as arrays by name. Cells of one type with one number
    of nodes make a block; the blocks are counted by n, the fields by k.

    points : (n_points, 3)
    cells.n : (n_cells, n_nodes) rows of points, of the n-th block
    dimensions : (n_blocks,) topological dimension of each block: 0 vertices, 1 lines, 2 faces, 3
        solids
    point names, cell names : of the fields
    point.k : (n_points,) or (n_points, m), values of the k-th field of the points
    cell.k.n : (n_cells,) or (n_cells, m), values of the k-th field of the cells in the n-th block

    Raises
    ------
    ValueError
        For whatever VTK complains of, points that are no numbers, cells without points and cells of
        points that are not there.
    """
    # complaints: errors and warnings of VTK; grid: its mesh with fields, None without one
    with _VtkComplaints() as complaints:
        grid = _read_grid(path)
    if complaints.text:
        raise ValueError(complaints.first)
    if grid is None:
        raise ValueError("it holds no mesh")
    points = _points(grid)
    block_arrays, blocks = _cell_blocks(grid, len(points))

    # fields of numbers: name -> a row of values for each point or cell
    point_fields = _numeric_fields(grid.GetPointData(), len(points))
    cell_fields = _numeric_fields(grid.GetCellData(), grid.GetNumberOfCells())
    arrays: dict[str, NDArray[Any]] = {
        "points": points,
        **block_arrays,
        "point names": np.array(list(point_fields), np.str_),
        "cell names": np.array(list(cell_fields), np.str_),
    }
    for field_number, values in enumerate(point_fields.values()):
        arrays[f"point.{field_number}"] = np.asarray(values, float)
    for field_number, values in enumerate(cell_fields.values()):
        for block_number, block in enumerate(blocks):
            arrays[f"cell.{field_number}.{block_number}"] = np.asarray(values, float)[block]
    return arrays


def _points(grid: Any) -> NDArray[np.float64]:
    """Coordinates (n_points, 3) of the points of a VTK mesh, in the file's unit of length.

    Raises
    ------
    ValueError
        Where a coordinate is not finite or larger than 1e100.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy

    points = np.zeros((0, 3))
    if grid.GetNumberOfPoints():
        points = np.asarray(vtk_to_numpy(grid.GetPoints().GetData()), float)
    if not (np.abs(points) <= _LARGEST_COORDINATE).all():
        raise ValueError(
            f"its points are not three finite numbers each, of at most {_LARGEST_COORDINATE:g}"
        )
    return points


def _cell_blocks(
    grid: Any, n_points: int
) -> tuple[dict[str, NDArray[Any]], list[NDArray[np.int64]]]:
    """The cells of a VTK mesh in blocks, each of one cell type with one number of nodes: arrays by
    name, and for each block the indices of its cells in the mesh.

    cells.n : (n_cells, n_nodes) rows of points, of the n-th block
    dimensions : (n_blocks,) topological dimension of each block: 0 vertices, 1 lines, 2 faces, 3
        solids

    Raises
    ------
    ValueError
        Where a cell has no points, or one beyond the `n_points` of the mesh.
    """
    nodes, starts = _nodes_of_cells(grid, n_points)
    cell_types = np.array(
        [grid.GetCellType(cell) for cell in range(grid.GetNumberOfCells())], np.int64
    )
    types_and_sizes = np.column_stack([cell_types, np.diff(starts)])
    blocks = [
        np.flatnonzero((types_and_sizes == type_and_size).all(axis=1))
        for type_and_size in np.unique(types_and_sizes, axis=0)
    ]
    arrays: dict[str, NDArray[Any]] = {}
    for block_number, block in enumerate(blocks):
        n_nodes = types_and_sizes[block[0], 1]
        arrays[f"cells.{block_number}"] = nodes[starts[block][:, None] + np.arange(n_nodes)]
    arrays["dimensions"] = np.array(
        [grid.GetCell(int(block[0])).GetCellDimension() for block in blocks], np.int64
    )
    return arrays, blocks


def _nodes_of_cells(grid: Any, n_points: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The nodes of all cells of a VTK mesh, one cell after the other, as rows of its points; and
    where those of each cell start, (n_cells + 1,), the last number being the end.

    Raises
    ------
    ValueError
        Where a cell has no points, or one beyond the `n_points` of the mesh.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy

    nodes = np.asarray(vtk_to_numpy(grid.GetCells().GetConnectivityArray()), np.int64)
    starts = np.asarray(vtk_to_numpy(grid.GetCells().GetOffsetsArray()), np.int64)
    if len(nodes) and not 0 <= nodes.min() <= nodes.max() < n_points:
        raise ValueError("a cell names a point that is not there")
    if np.any(np.diff(starts) <= 0):  # a file may even say that a cell has -1
        raise ValueError("a cell has no points")
    return nodes, starts


def _read_grid(path: Path) -> Any:
    """The mesh with its fields in a .vtu file, or whatever mesh a .vtk file holds, as a
    vtkUnstructuredGrid; None where the file holds none.
    """
    if path.suffix.lower() == ".vtu":
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

        vtu_reader = vtkXMLUnstructuredGridReader()
        vtu_reader.SetFileName(str(path))
        vtu_reader.Update()
        return vtu_reader.GetOutput()

    from vtkmodules.vtkFiltersCore import vtkAppendFilter
    from vtkmodules.vtkIOLegacy import vtkDataSetReader

    legacy_reader = vtkDataSetReader()
    legacy_reader.SetFileName(str(path))
    for kind_of_data in ("Scalars", "ColorScalars", "Normals", "TCoords", "Vectors", "Fields"):
        getattr(legacy_reader, f"ReadAll{kind_of_data}On")()
    legacy_reader.ReadAllTensorsOn()
    legacy_reader.Update()
    mesh = legacy_reader.GetOutput()
    if mesh is None or mesh.GetClassName() == "vtkUnstructuredGrid":
        return mesh
    # the filter that appends meshes turns a single one of another class into an unstructured grid
    append_filter = vtkAppendFilter()
    append_filter.SetOutputPointsPrecision(vtkAppendFilter.DOUBLE_PRECISION)
    append_filter.AddInputData(mesh)
    append_filter.Update()
    return append_filter.GetOutput()


def _numeric_fields(attributes: Any, n_places: int) -> dict[str, NDArray[Any]]:
    """Name -> array, of those fields that hold numbers among the VTK fields of points or cells
    (`attributes`). Each array has a row for each of the `n_places` points or cells.

    Raises
    ------
    ValueError
        Where a field has another number of rows.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy

    fields = {}
    for array_number in range(attributes.GetNumberOfArrays()):
        field = attributes.GetArray(array_number)
        if field is None:  # words, no numbers
            continue
        name = field.GetName() or f"Unnamed_{array_number}"
        fields[name] = vtk_to_numpy(field)
        if len(fields[name]) != n_places:
            raise ValueError(f"{name} has {len(fields[name])} values for {n_places} places")
    return fields


class _VtkComplaints:
    """A context that records what VTK writes into its output window, errors and warnings: it reads
    on after many of them.
    """

    text = ""

    def __enter__(self) -> _VtkComplaints:
        from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow

        self._window = vtkStringOutputWindow()
        self._before = vtkOutputWindow.GetInstance()
        vtkOutputWindow.SetInstance(self._window)
        return self

    def __exit__(self, *_: object) -> None:
        from vtkmodules.vtkCommonCore import vtkOutputWindow

        self.text = self._window.GetOutput()
        vtkOutputWindow.SetInstance(self._before)

    @property
    def first(self) -> str:
        """The first complaint, without the place in VTK and the address of an object."""
        lines = [
            line
            for line in self.text.splitlines()
            if line and not line.startswith(("ERROR:", "Warning:"))
        ]
        return re.sub(r" \(0x[0-9a-f]+\)", "", lines[0]) if lines else "VTK gives no reason"


def _limit_process(most_bytes: int, seconds: int) -> None:
    """Limit this process from now on: it may grow by `most_bytes` of memory and compute for
    `seconds` (POSIX only; nothing is limited elsewhere).
    """
    try:
        import resource
    except ImportError:
        return
    pages_of_memory = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    memory_bytes = pages_of_memory * resource.getpagesize() + most_bytes
    # RLIMIT_AS: address space in bytes; RLIMIT_CPU: processor time in seconds
    for resource_kind, amount in (
        (resource.RLIMIT_AS, memory_bytes),
        (resource.RLIMIT_CPU, seconds),
    ):
        _, hard_limit = resource.getrlimit(resource_kind)
        limit = amount
        if hard_limit != resource.RLIM_INFINITY:
            limit = min(amount, hard_limit)
        resource.setrlimit(resource_kind, (limit, limit))


def _write_to_stderr(about: dict[str, Any]) -> None:
    sys.stderr.write(f"{json.dumps(about)}\n")
    sys.stderr.flush()


def numbered_arrays(paths: list[str]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Arrays of meshes and fields of VTK files, by a name that begins with the number of the file:
    (name, array) one after the other. On stderr stands the number before each file; for one that
    can't be read also the reason, and the process ends with code 1.
    """
    for file_number, path in enumerate(paths):
        _write_to_stderr({"file": file_number})
        try:
            arrays = arrays_of(Path(path))
        except Exception as reason:  # noqa: BLE001 (whatever a broken file makes VTK raise)
            _write_to_stderr({"file": file_number, "reason": f"{type(reason).__name__}: {reason}"})
            raise SystemExit(1) from None
        for name, array in arrays.items():
            yield f"{file_number}.{name}", array


def main() -> None:
    """Read the files that stdin names as a JSON list, and write their arrays as npz to stdout. The
    command line states the most memory [bytes] and processor time [s].
    """
    # The memory that these modules take is not counted in the limit.
    import vtkmodules.vtkFiltersCore
    import vtkmodules.vtkIOLegacy
    import vtkmodules.vtkIOXML  # noqa: F401

    _limit_process(int(sys.argv[1]), int(sys.argv[2]))
    content = io.BytesIO()
    np.savez(content, **dict(numbered_arrays(json.load(sys.stdin))))  # type: ignore[arg-type]
    sys.stdout.buffer.write(content.getbuffer())


if __name__ == "__main__":
    main()
