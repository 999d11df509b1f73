"""Field files that other programs wrote, of one instant or of many: VTU, legacy VTK, and PVD, their
collection.

VTK reads them in a process of its own, bounded in time and memory: see `vtk_files`.
"""

from __future__ import annotations

import io
import itertools
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from reports.scoring import vtk_files
from scenes import InputError
from scenes.array_types import Array
from scenes.errors import in_words
from scenes.files import require_readable_size, within_memory

Integers = NDArray[np.int64]

# bytes: of a file, of memory that one may take
MOST_BYTES_OF_FILE = 2**29
MOST_UNPACKED_BYTES = 2**31
MOST_SECONDS_OF_READING = 300  # of reading: half a GB takes some ten
_SUFFIXES = (".vtu", ".vtk")
# What Python, VTK and C++ print where memory ends.
_OUT_OF_MEMORY = ("MemoryError", "nable to allocate", "bad_alloc")


@dataclass(frozen=True, eq=False)
class FieldPart:
    """A mesh and its fields: a body in a file of its own, or all that one file holds.

    Attributes
    ----------
    name
        of its file
    points
        (n_points, 3) [length]
    cells
        blocks (dimension, (n_cells, n_nodes) numbers of points); dimension 0 of vertices, 1 of
        lines, 2 of faces, 3 of solids
    point_fields
        name -> (n_points,) or (n_points, k)
    cell_fields
        name -> a block for each of `cells`, (n_cells,) or (n_cells, k)
    """

    name: str
    points: Array
    cells: tuple[tuple[int, Integers], ...]
    point_fields: dict[str, Array]
    cell_fields: dict[str, tuple[Array, ...]]


@dataclass(frozen=True, eq=False)
class FieldFrame:
    """One instant: its time as the collection states it (None for a single file), and its parts,
    each with fields of its own.
    """

    time: float | None
    parts: tuple[FieldPart, ...]


def read_frames(path: str | Path) -> list[FieldFrame]:
    """Every instant of a .vtu, .vtk or .pvd file; those of a .pvd, which states times, in their
    order.

    An instant holds one part for each file that a .pvd collection names at its time, such as one
    for each body; a part is a mesh with its fields.

    Raises
    ------
    InputError
        File and what is wrong: can't be read, broken, larger than half a GB (2 GB unpacked), longer
        than five minutes to read, no instant, an instant without a time, a file of the collection
        missing.
    """
    path = Path(path)
    if path.suffix.lower() != ".pvd":
        return [FieldFrame(None, tuple(_parts_of_files([path])))]
    # (time, file), NaN where no time is stated
    entries = _times_and_files(path)
    if not entries:
        raise InputError(f"{path}: the collection is empty")
    for time, file in entries:
        if not file.is_file():
            raise InputError(
                f"{path}: it names {file.name}, which is not there; keep the files of a collection"
                " together"
            )
        if not np.isfinite(time):
            raise InputError(f"{path}: {file.name} has no time in it (timestep)")
    # mesh and fields of each file
    parts = _parts_of_files([file for _, file in entries])
    frames: dict[float, list[FieldPart]] = {}
    for (time, _), part in zip(entries, parts, strict=True):
        frames.setdefault(time, []).append(part)
    return [FieldFrame(time, tuple(frames[time])) for time in sorted(frames)]


def collected_files(path: Path) -> tuple[Path, ...]:
    """The files that a .pvd names; none of any other file. InputError where the collection is
    broken.
    """
    return (
        tuple(file for _, file in _times_and_files(path)) if path.suffix.lower() == ".pvd" else ()
    )


def _times_and_files(path: Path) -> list[tuple[float, Path]]:
    """Entries of a .pvd collection, (time, file) each: the files it names, which lie beside it;
    time is NaN where none is stated. InputError where the collection is broken.
    """
    _check_size(path)
    try:
        # stops, with an InputError, where the process grows by more than 2 GB
        with within_memory(path, MOST_UNPACKED_BYTES):
            root = ElementTree.parse(path).getroot()
        if root.get("type") != "Collection":
            raise InputError(
                f"{path}: a VTKFile of type Collection is expected, this is {root.tag} of type"
                f" {root.get('type')}"
            )
        return [
            (float(entry.get("timestep", "nan")), path.parent / str(entry.get("file")))
            for entry in root.iter("DataSet")
        ]
    except (OSError, ElementTree.ParseError, ValueError) as reason:
        raise _error_of_broken_file(path, f"{type(reason).__name__}: {reason}") from reason


def _check_size(path: Path) -> None:
    """InputError for a field file that is too large or can't be read."""
    try:
        require_readable_size(
            path, "the result", MOST_BYTES_OF_FILE, "write the contact surface alone"
        )
    except OSError as reason:
        raise InputError(f"{path}: the result can't be read: {reason.strerror}") from reason


def _error_of_broken_file(path: Path, reason: str) -> InputError:
    """The InputError for a field file that can't be read, with the reader's reason."""
    return InputError(
        f"{path}: this can't be read as a {path.suffix} file: it is broken off or of another form"
        f" ({reason[:300]})"
    )


def _parts_of_files(paths: Sequence[Path]) -> list[FieldPart]:
    """The mesh and the fields of each of these VTK files, in their order. InputError for a suffix
    that no reader takes, and for a file that is too large.
    """
    for path in paths:
        if path.suffix.lower() not in _SUFFIXES:
            raise InputError(
                f"{path}: no reader for {path.suffix!r} within a collection; it reads"
                f" {', '.join(_SUFFIXES)}"
            )
        _check_size(path)
    # the files are read in another process, which returns an NPZ archive
    with np.load(io.BytesIO(_read_in_process(paths)), allow_pickle=False) as content:
        arrays = {name: content[name] for name in content.files}
    return [
        _part_of_file(path, f"{file_number}.", arrays) for file_number, path in enumerate(paths)
    ]


def _read_in_process(paths: Sequence[Path]) -> bytes:
    """Read VTK files in a process of its own, which may crash, need too much memory (2 GB) or take
    too long (five minutes) without harm to this one. Returns the arrays of all files as bytes of an
    NPZ archive. InputError, naming the file, where that fails.
    """
    # a Python that runs `vtk_files`, with limits of memory and processor time
    command = [
        sys.executable,
        "-P",
        str(vtk_files.__file__),
        str(MOST_UNPACKED_BYTES),
        str(int(MOST_SECONDS_OF_READING) + 1),
    ]
    request = json.dumps([str(path.absolute()) for path in paths]).encode()
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        process = subprocess.run(
            command,
            input=request,
            capture_output=True,
            timeout=MOST_SECONDS_OF_READING,
            env=environment,
            check=False,
        )
    except subprocess.TimeoutExpired as expiry:
        # the last file that the reader named before it was stopped
        path, _ = _file_and_reason(paths, expiry.stderr or b"")
        raise InputError(
            f"{path}: reading takes longer than {MOST_SECONDS_OF_READING:g} s,"
            " which is the limit; write the contact surface alone, and fewer instants"
        ) from expiry
    if process.returncode == 0:
        return process.stdout
    path, reason = _file_and_reason(paths, process.stderr)
    # phrases that Python, VTK and C++ print where memory ends
    if any(phrase in process.stderr.decode(errors="replace") for phrase in _OUT_OF_MEMORY):
        raise InputError(
            f"{path}: unpacked it takes more than {in_words(MOST_UNPACKED_BYTES)} of memory, which"
            " is the limit; write the contact surface alone"
        )
    raise _error_of_broken_file(
        path, reason or f"VTK's reader ended with code {process.returncode}"
    )


def _file_and_reason(paths: Sequence[Path], output: bytes) -> tuple[Path, str]:
    """The file that the reader of VTK files was at when it ended, and its reason if it gave one;
    from its `output` on stderr, lines of JSON with the number of the file among `paths`.
    """
    lines = [
        line
        for line in output.decode(errors="replace").splitlines()
        if line.startswith('{"file": ')
    ]
    last_line: dict[str, Any] = json.loads(lines[-1]) if lines else {"file": 0}
    return paths[int(last_line["file"])], str(last_line.get("reason", ""))


def _part_of_file(path: Path, prefix: str, arrays: dict[str, NDArray[Any]]) -> FieldPart:
    """Mesh and fields of one file, from the arrays that the reader of VTK files has written.

    Parameters
    ----------
    path
        the file
    prefix
        what the names of this file's arrays begin with, such as "0."
    arrays
        name -> array: points, blocks of cells, values at points and values of cells
    """
    # of the cells of each block: 0 vertices, 1 lines, 2 faces, 3 solids
    dimensions = arrays[f"{prefix}dimensions"].tolist()
    names_of_point_fields = arrays[f"{prefix}point names"].tolist()
    names_of_cell_fields = arrays[f"{prefix}cell names"].tolist()
    cells = tuple(
        (dimension, arrays[f"{prefix}cells.{block_number}"])
        for block_number, dimension in enumerate(dimensions)
    )
    point_fields = {
        name: arrays[f"{prefix}point.{field_number}"]
        for field_number, name in enumerate(names_of_point_fields)
    }
    cell_fields = {}
    for field_number, name in enumerate(names_of_cell_fields):
        cell_fields[name] = tuple(
            arrays[f"{prefix}cell.{field_number}.{block_number}"]
            for block_number in range(len(dimensions))
        )
    return FieldPart(path.name, arrays[f"{prefix}points"], cells, point_fields, cell_fields)


def joined_mesh(parts: Sequence[FieldPart]) -> FieldPart:
    """Parts of one instant of a field file, such as the bodies, as one mesh with the fields that
    all of them have. A part has `points` (n, 3), `cells` (blocks of one kind with its dimension)
    and fields at points and at cells by name.

    Raises
    ------
    InputError
        Where a field has other numbers of components in two parts.
    """
    if len(parts) == 1:
        return parts[0]
    common_point_fields = _names_in_all([part.point_fields for part in parts])
    common_cell_fields = _names_in_all([part.cell_fields for part in parts])
    # all parts must have as many components of a field
    for field in common_point_fields:
        form_in_first_part = parts[0].point_fields[field].shape[1:]
        for part in parts[1:]:
            if part.point_fields[field].shape[1:] != form_in_first_part:
                raise InputError(
                    f"{parts[0].name}: {field} has another number of components than in"
                    f" {part.name}; write one form"
                )
    joined_cells = []
    n_points_before = 0
    for part in parts:
        joined_cells += [
            (dimension, point_numbers + n_points_before) for dimension, point_numbers in part.cells
        ]
        n_points_before += len(part.points)
    joined_point_fields = {
        field: np.concatenate([part.point_fields[field] for part in parts])
        for field in common_point_fields
    }
    joined_cell_fields = {}
    for field in common_cell_fields:
        blocks = itertools.chain.from_iterable(part.cell_fields[field] for part in parts)
        joined_cell_fields[field] = tuple(blocks)
    return FieldPart(
        ", ".join(part.name for part in parts),
        np.concatenate([part.points for part in parts]),
        tuple(joined_cells),
        joined_point_fields,
        joined_cell_fields,
    )


def _names_in_all(fields: Sequence[Mapping[str, Any]]) -> list[str]:
    """The names of the first that all of them have."""
    return [name for name in fields[0] if all(name in other_fields for other_fields in fields)]
