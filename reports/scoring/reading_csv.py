"""Tables of text: one row for each instant and point, or the frames of a path beside each other in columns."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reports.scoring.mapping import Mapping, Quantity, converted, find_column, stated_times
from reports.scoring.surface import SurfaceResult
from reports.scoring.tidying import surface_result
from reports.scoring.wide import frames_of, has_frames
from scenes import InputError, Scene
from scenes.errors import shown
from scenes.files import text_of
from scenes.measured import LARGEST

Array = NDArray[np.float64]
# Lines of a table of text; a cycle of a thousand instants at a thousand points has half as many.
MOST_ROWS = 2_000_000
_THIN = "write the contact surface alone, and fewer instants"
_ROWS: tuple[Quantity, ...] = ("time", "frame", "normal_load", "tangential_load", "x", "pressure", "shear", "slip")


@dataclass(frozen=True, eq=False)
class TextTable:
    """A table of a text file: `names` of its columns, `values` (n_rows, n_columns), `lines` of the file that the rows stand on."""

    names: tuple[str, ...]
    values: Array
    lines: tuple[int, ...]

    def column(self, name: str) -> Array:
        """The first column of that name, (n_rows,)."""
        return np.asarray(self.values[:, self.names.index(name)])


def read(path: Path, mapping: Mapping, scene: Scene) -> SurfaceResult:  # noqa: ARG001 (the readers' common signature)
    """The result in a table with a line of names: one row for each instant and point, or one for each point and columns for frames.

    Columns are separated by comma, semicolon, tab or blanks; with semicolons the decimal sign may be a comma. Lines that start
    with # are skipped. Instants are told apart by time, else by a number of the frame, else by the loads.

    Raises
    ------
    InputError
        One sentence that names the file, the line or column, and what to do.
    """
    table = read_table(path)
    if has_frames(table.names, mapping):
        wide = frames_of(path, table, mapping)
        if wide is not None:
            return wide
    needed = ("x", "pressure", "shear")
    columns = {name: find_column(mapping, name, table.names, str(path), needed=name in needed) for name in _ROWS}
    found = {quantity: converted(mapping, quantity, table.column(name)) for quantity, name in columns.items() if name is not None}
    return _rows(str(path), mapping, found)


def _rows(source: str, mapping: Mapping, columns: dict[Quantity, Array]) -> SurfaceResult:
    """From one row for each instant and point."""
    instants, by = _instants(columns)
    labels, counts = np.unique(instants, return_counts=True)
    if np.any(counts != counts[0]):
        odd = int(np.flatnonzero(counts != counts[0])[0])
        raise InputError(
            f"{source}: instant {odd + 1} (by {by}) has {counts[odd]} points and the first has {counts[0]}: every instant needs "
            "the same points, with zeros where nothing touches"
        )
    order = np.argsort(instants, kind="stable")
    shaped = {name: values[order].reshape(len(labels), -1) for name, values in columns.items() if name != "frame"}
    rank = np.argsort(shaped["x"], axis=1, kind="stable")
    shaped = {name: np.take_along_axis(values, rank, axis=1) for name, values in shaped.items()}
    series = {name: _constant(source, name, shaped.get(name), by) for name in ("time", "normal_load", "tangential_load")}
    if mapping.times is not None:
        series["time"] = stated_times(source, mapping, len(labels))
    notes = [] if np.all(np.diff(instants) >= 0) else ["the rows were not in the order of the instants and were sorted"]
    if np.any(np.diff(rank, axis=1) < 0):
        notes.append("the points were not in the order of x and were sorted")
    fields = {name: shaped.get(name) for name in ("pressure", "shear", "slip")}
    return surface_result(source, mapping.code, shaped["x"], dict(fields), dict(series), notes)


def _instants(columns: dict[Quantity, Array]) -> tuple[NDArray[np.intp], str]:
    """(n_rows,) number of the instant of each row in the order of time, and by what it was told."""
    for key in ("time", "frame"):
        if key in columns:
            return np.unique(columns[key], return_inverse=True)[1], key
    if "normal_load" in columns:
        loads = np.column_stack([columns["normal_load"], columns.get("tangential_load", columns["normal_load"])])
        return np.concatenate([[0], np.cumsum(np.any(np.diff(loads, axis=0) != 0, axis=1))]), "the loads"
    return np.zeros(len(columns["x"]), dtype=np.intp), "nothing"


def _constant(source: str, name: str, values: Array | None, by: str) -> Array | None:
    """The one figure of each instant; InputError where its rows differ."""
    if values is None:
        return None
    with np.errstate(invalid="ignore"):  # what a factor made infinite is refused with all that is not finite
        odd = np.flatnonzero(np.ptp(values, axis=1) > 1e-9 * np.max(np.abs(values)))
    if len(odd):
        row = values[odd[0]]
        raise InputError(f"{source}: {name} goes from {row.min():.6g} to {row.max():.6g} within instant {odd[0] + 1} (by {by})")
    return np.asarray(values[:, 0])


def read_table(path: Path) -> TextTable:
    """The numbers below the first line of names; InputError for a line of another length or a cell that is no number."""
    text = text_of(path, "the result", advice=_THIN)
    if text.count("\n") > MOST_ROWS:
        raise InputError(f"{path}: the result has more than {MOST_ROWS:,} lines, the most that are read; {_THIN}")
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith(("#", "**"))]
    del text
    if not lines:
        raise InputError(f"{path}: the file is empty; a line of names and rows of numbers are needed")
    (first, head), rows = lines[0], lines[1:]
    mark = next((sign for sign in ("\t", ";", ",") if sign in head), None)
    names = tuple(cell.strip().strip('"').strip() for cell in head.split(mark))
    if all(_number(name) is not None for name in names):
        raise InputError(
            f"{path}, line {first}: the first line must name the columns, such as time,x,pressure,shear; it has numbers only"
        )
    if not rows:
        raise InputError(f"{path}: no row of numbers below the names {', '.join(names)}")
    values = array("d")
    for line, row in rows:
        values.extend(_cells(path, line, row, mark, names))
    return TextTable(names, np.array(values).reshape(len(rows), len(names)), tuple(line for line, _ in rows))


def _cells(path: Path, line: int, text: str, mark: str | None, names: tuple[str, ...]) -> list[float]:
    cells = [cell.strip().strip('"') for cell in text.split(mark)]
    if len(cells) == len(names) + 1 and not cells[-1]:
        cells.pop()
    if len(cells) != len(names):
        raise InputError(f"{path}, line {line}: {len(names)} numbers are needed ({', '.join(names[:6])} ...), not {len(cells)}")
    numbers = [_number(cell.replace(",", ".") if mark == ";" else cell) for cell in cells]
    for name, cell, number in zip(names, cells, numbers, strict=True):
        if number is None or not abs(number) <= LARGEST:
            raise InputError(f"{path}, line {line}: {name} = {shown(cell)} is not a finite number; mend it or leave out the row")
    return [float(number) for number in numbers if number is not None]


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
