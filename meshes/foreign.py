"""Field files that other programs wrote, of one instant or of many: VTU, legacy VTK, XDMF by meshio, and collections of them."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
from meshio._exceptions import CorruptionError
from numpy.typing import NDArray

from scenes import InputError
from scenes.files import check_size, parsed_json, within_memory

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_FARTHEST = 1e100  # the square of a larger coordinate would be none
LARGEST, UNPACKED = 2**29, 2**31  # bytes: of a file, of memory that one may take

# What meshio, the XML parser and numpy raise on files that are broken off or are none; meshio checks some forms by `assert`.
_FAULTS = (
    CorruptionError,
    meshio.ReadError,
    ElementTree.ParseError,
    AssertionError,
    AttributeError,
    EOFError,
    IndexError,
    KeyError,
    OSError,
    OverflowError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
    zlib.error,
)


@dataclass(frozen=True, eq=False)
class FieldPart:
    """A mesh and its fields: a body in a file of its own, or all that one file holds.

    Attributes
    ----------
    name : of its file
    points : (n_points, 3) [length]
    cells : (kind, (n_cells, n_nodes)) blocks; kinds as meshio calls them, such as "line", "quad8"
    point_fields : name -> (n_points,) or (n_points, k)
    cell_fields : name -> a block for each of `cells`, (n_cells,) or (n_cells, k)
    """

    name: str
    points: Array
    cells: tuple[tuple[str, Integers], ...]
    point_fields: dict[str, Array]
    cell_fields: dict[str, tuple[Array, ...]]


@dataclass(frozen=True, eq=False)
class FieldFrame:
    """One instant: its time as the collection states it (None for a single file), and its parts, each with fields of its own."""

    time: float | None
    parts: tuple[FieldPart, ...]


def read_frames(path: str | Path) -> list[FieldFrame]:
    """Every instant of a .vtu, .vtk, .pvd, .vtu.series or .xdmf (.xmf) file, in the order of time where times are stated.

    Bodies of one instant in files of their own stay parts with fields of their own; see `joined`.

    Raises
    ------
    InputError
        File and what is wrong: can't be read, broken, larger than half a GB (2 GB unpacked), no instant, a file of the collection
        missing.
    """
    path = Path(path)
    _check_size(path)
    kind = path.suffix.lower()
    try:
        with within_memory(path, UNPACKED):
            if kind == ".pvd":
                return _collected(path, list(_pvd_entries(path)))
            if kind == ".series":
                return _collected(path, list(_series_entries(path)))
            if kind in {".xdmf", ".xmf"}:
                return _xdmf(path)
            return [FieldFrame(None, (_single(path),))]
    except InputError:
        raise
    except _FAULTS as reason:
        raise _broken(path, reason) from reason


def collected_files(path: Path) -> tuple[Path, ...]:
    """The files that a .pvd or .vtu.series names; none of any other file. InputError where the collection is broken."""
    entries = {".pvd": _pvd_entries, ".series": _series_entries}.get(path.suffix.lower())
    if entries is None:
        return ()
    _check_size(path)
    try:
        return tuple(file for _, file in entries(path))
    except _FAULTS as reason:
        raise _broken(path, reason) from reason


def _broken(path: Path, reason: Exception) -> InputError:
    what = f"{type(reason).__name__}{f': {reason}' if str(reason) else ''}"[:300]
    return InputError(f"{path}: this can't be read as a {path.suffix} file: it is broken off or of another form ({what})")


def _check_size(path: Path) -> None:
    try:
        check_size(path, "the result", LARGEST, "write the contact surface alone")
    except OSError as reason:
        raise InputError(f"{path}: the result can't be read: {reason.strerror}") from reason


def _pvd_entries(path: Path) -> Iterator[tuple[float, Path]]:
    root = ElementTree.parse(path).getroot()
    if root.get("type") != "Collection":
        raise InputError(f"{path}: a VTKFile of type Collection is expected, this is {root.tag} of type {root.get('type')}")
    for entry in root.iter("DataSet"):
        yield float(entry.get("timestep", "nan")), path.parent / str(entry.get("file"))


def _series_entries(path: Path) -> Iterator[tuple[float, Path]]:
    for entry in parsed_json(path.read_text(encoding="utf-8"))["files"]:
        yield float(entry["time"]), path.parent / str(entry["name"])


def _collected(path: Path, entries: Sequence[tuple[float, Path]]) -> list[FieldFrame]:
    """One frame for each time, of all its parts."""
    if not entries:
        raise InputError(f"{path}: the collection is empty")
    for time, file in entries:
        if not file.is_file():
            raise InputError(f"{path}: it names {file.name}, which is not there; keep the files of a collection together")
        if not np.isfinite(time):
            raise InputError(f"{path}: {file.name} has no time in it (timestep)")
    times = sorted({time for time, _ in entries})
    return [FieldFrame(time, tuple(_single(file) for own, file in entries if own == time)) for time in times]


def _single(path: Path) -> FieldPart:
    """By the reader of the suffix itself: meshio's general one ends the process where a file is broken."""
    _check_size(path)
    readers = {".vtu": meshio.vtu.read, ".vtk": meshio.vtk.read, ".xdmf": meshio.xdmf.read, ".xmf": meshio.xdmf.read}
    read = readers.get(path.suffix.lower())
    if read is None:
        raise InputError(f"{path}: no reader for {path.suffix!r} within a collection; it reads {', '.join(readers)}")
    try:
        return _part(path, read(path))
    except _FAULTS as reason:
        raise _broken(path, reason) from reason


def _xdmf(path: Path) -> list[FieldFrame]:
    """A series where the file is one, else its only instant."""
    root = ElementTree.parse(path).getroot()
    if not any(grid.get("CollectionType") == "Temporal" for grid in root.iter("Grid")):
        return [FieldFrame(None, (_single(path),))]
    frames = []
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, cells = reader.read_points_cells()
        for k in range(reader.num_steps):
            time, point_data, cell_data = reader.read_data(k)
            frames.append(FieldFrame(float(time), (_part(path, meshio.Mesh(points, cells, point_data, cell_data)),)))
    if not frames:
        raise InputError(f"{path}: the series has no instant")
    return frames


def _part(path: Path, mesh: meshio.Mesh) -> FieldPart:
    points = np.asarray(mesh.points, float)
    if points.ndim != 2 or not 1 <= points.shape[1] <= 3 or not (np.abs(points) <= _FARTHEST).all():
        raise ValueError(f"its points are not two or three finite numbers each, of at most {_FARTHEST:g}")
    flat = np.zeros((len(points), 3))
    flat[:, : points.shape[1]] = points
    blocks = range(len(mesh.cells))
    for block in mesh.cells:
        rows = np.asarray(block.data)
        if rows.size and (rows.min() < 0 or rows.max() >= len(points)):
            raise ValueError(f"a cell of kind {block.type} names a point that is not there")
    for name, values in mesh.point_data.items():
        if len(values) != len(points):
            raise ValueError(f"{name} has {len(values)} values for {len(points)} points")
    return FieldPart(
        path.name,
        flat,
        tuple((block.type, np.asarray(block.data, np.int64)) for block in mesh.cells),
        {name: np.asarray(values, float) for name, values in mesh.point_data.items()},
        {name: tuple(np.asarray(values[k], float) for k in blocks) for name, values in mesh.cell_data.items()},
    )


def joined(parts: Sequence[FieldPart]) -> FieldPart:
    """The parts as one mesh, with the fields that all of them have: choose parts that have what is looked for.

    Raises
    ------
    InputError
        Where a field is a scalar in one part and a vector in another.
    """
    if len(parts) == 1:
        return parts[0]
    starts = np.concatenate([[0], np.cumsum([len(part.points) for part in parts])])
    of_points = [name for name in parts[0].point_fields if all(name in part.point_fields for part in parts)]
    of_cells = [name for name in parts[0].cell_fields if all(name in part.cell_fields for part in parts)]
    for field in of_points:
        if len({part.point_fields[field].shape[1:] for part in parts}) > 1:
            raise InputError(f"{parts[0].name}: {field} has another number of components than in {parts[1].name}; write one form")
    return FieldPart(
        ", ".join(part.name for part in parts),
        np.concatenate([part.points for part in parts]),
        tuple((kind, rows + start) for part, start in zip(parts, starts, strict=False) for kind, rows in part.cells),
        {name: np.concatenate([part.point_fields[name] for part in parts]) for name in of_points},
        {name: tuple(block for part in parts for block in part.cell_fields[name]) for name in of_cells},
    )
