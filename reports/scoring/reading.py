"""Which reader takes which file; and tables of text, a row for each instant and point or frames
beside each other.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from reports.scoring.abaqus import is_field_report, read_field_report
from reports.scoring.mapping import (
    Mapping,
    Quantity,
    conversion_in_words,
    converted,
    find_column,
    stated_times,
)
from reports.scoring.surface import SurfaceResult, surface_result
from scenes import InputError
from scenes.array_types import Array
from scenes.column_names import ALIASES, plain
from scenes.measured import layout_in_words
from scenes.text_tables import TableKind, TextTable, text_table

_TABLES = (".csv", ".txt", ".rpt")
# Suffix -> module and function, each read(path, mapping) -> SurfaceResult; loaded when a file asks
# for it.
# A solution of this program.
OWN = ".nc"
READERS: dict[str, str] = {
    **dict.fromkeys(_TABLES, "reading:read_table"),
    ".frd": "calculix:read_results",
    ".dat": "calculix:read_printed",
    **dict.fromkeys((".vtu", ".vtk", ".pvd"), "fields:read_fields"),
}
_ROWS: tuple[Quantity, ...] = (
    "time",
    "frame",
    "normal_load",
    "tangential_load",
    "x",
    "pressure",
    "shear",
    "slip",
)
_FIELDS: tuple[Quantity, ...] = ("x", "pressure", "shear", "slip")
_OTHERS = {plain(alias) for name in _ROWS for alias in ALIASES[name]}
# "CPRESS Frame 12", "CSHEAR1 at t=0.5", "p_3": the name, then perhaps a word for what the figure
# counts, then the figure. A run of signs belongs to no name and is never tried in parts: 3,000
# brackets as a name took 8 s, with the cube of their number.
_TAGGED = re.compile(
    r"^(?P<base>.+?)(?<![\s_:@,.;\-(\[])[\s_:@,.;\-(\[]++(?:at\s+)?"
    r"(?P<word>step[\s_]?time|total[\s_]?time|time|frame|increment|inc|f|t|step)?"
    r"[\s_:=#]*(?P<figure>\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)\s*s?[)\]]?$",
    re.IGNORECASE,
)


def read(path: Path, mapping: Mapping) -> SurfaceResult:
    """The external result in a file, in the scene's units and our signs as far as the mapping
    states them. The suffix says which reader takes it.

    Raises
    ------
    InputError
        One sentence: no such file, no reader for it, or what its reader found.
    """
    if not path.exists():
        raise InputError(f"{path}: there is no such file")
    reader_name = READERS.get(path.suffix.lower())
    if reader_name is None:
        raise InputError(
            f"{path}: no reader for {path.suffix or 'a file without suffix'!r}; it reads"
            f" {', '.join(sorted(READERS))}, .nc"
        )
    module, function = reader_name.split(":")
    reader = getattr(import_module(f"reports.scoring.{module}"), function)
    return cast(SurfaceResult, reader(path, mapping))


def read_table(path: Path, mapping: Mapping) -> SurfaceResult:
    """The external result in a text table with a line of names: one row for each instant and point,
    or one for each point and columns for frames.

    Instants differ by time, else by a number of the frame, else by the loads. `mapping` states
    columns, units and signs of the file.

    Raises
    ------
    InputError
        One sentence that names the file, the line or column, and what to do.
    """
    source = str(path)
    if path.suffix.lower() == ".rpt" and path.is_file() and is_field_report(path):
        return _surface_of_rows(source, mapping, *read_field_report(path, mapping))
    table = text_table(
        path,
        kind=TableKind(
            role="the result",
            cure="write the contact surface alone, and fewer instants",
            is_known=lambda name: (
                _quantity_of_heading(name, mapping).quantity is not None or plain(name) in _OTHERS
            ),
        ),
    )
    frames = _columns_of_frames(source, table, mapping)
    if frames is not None:
        columns, notes = frames
        quantities = [_quantity_of_heading(name, mapping).quantity for name in table.names]
        surface = _surface_of_rows(source, mapping, columns, notes)
        surface = _with_words_on_columns(surface, table, mapping, quantities)
        return _with_places_of_outliers(surface, table, mapping)
    columns = {}
    quantity_of: dict[str, Quantity] = {}
    for quantity in _ROWS:
        name = find_column(
            mapping, quantity, table.names, source, needed=quantity in ("x", "pressure")
        )
        if name is not None:
            columns[quantity] = converted(mapping, quantity, table.column(name))
            quantity_of[name] = quantity
    surface = _surface_of_rows(source, mapping, columns, [])
    quantities = [quantity_of.get(name) for name in table.names]
    surface = _with_words_on_columns(surface, table, mapping, quantities)
    return _with_places_of_outliers(surface, table, mapping)


def _with_words_on_columns(
    surface: SurfaceResult,
    table: TextTable,
    mapping: Mapping,
    quantities: Sequence[Quantity | None],
) -> SurfaceResult:
    """An external result with a note on every column of its table: the quantity it was read as,
    with factor and sign, or "not read".

    Parameters
    ----------
    mapping
        stated columns, units and signs of the file
    quantities
        quantity of each column, in the order of the table; None for a column that was not read
    """
    read_as = layout_in_words(Path(surface.source), table)
    for name, quantity in zip(table.names, quantities, strict=True):
        column_in_words = "not read" if quantity is None else conversion_in_words(mapping, quantity)
        read_as.append((f"column {name}", column_in_words))
    return replace(surface, read_as=tuple(read_as))


def _with_places_of_outliers(
    surface: SurfaceResult, table: TextTable, mapping: Mapping
) -> SurfaceResult:
    """An external result with line, column and written number in the file for each of its outliers.

    An outlier is a single value that stands out of all others. It is found again in the table by
    its size, since values were multiplied by a factor on reading. `mapping` states columns, units
    and signs of the file.
    """
    if not surface.outliers:
        return surface
    sizes_in_table = np.abs(table.values)
    outliers = []
    for outlier in surface.outliers:
        # The cell whose figure is the outlier's, but for the factor that all cells of its field
        # have.
        field = np.abs(getattr(surface, outlier.quantity))
        columns_of_quantity = [
            number
            for number, heading in enumerate(table.names)
            if _quantity_of_heading(heading, mapping).quantity == outlier.quantity
        ]
        sizes_of_quantity = sizes_in_table[:, columns_of_quantity]
        factor = float(field.max() / sizes_of_quantity.max())
        table_row, number_among_columns = np.unravel_index(
            np.argmin(np.abs(sizes_of_quantity * factor - abs(outlier.value))),
            sizes_of_quantity.shape,
        )
        column_name = table.names[columns_of_quantity[number_among_columns]]
        place_in_file = f"line {table.lines[table_row]}, column {column_name!r} ({outlier.place})"
        written_number = float(table.values[table_row, columns_of_quantity[number_among_columns]])
        outliers.append(replace(outlier, place=place_in_file, figure=written_number))
    return replace(surface, outliers=tuple(outliers))


def _surface_of_rows(
    source: str, mapping: Mapping, columns: dict[Quantity, Array], notes: list[str]
) -> SurfaceResult:
    """An external result from columns with one row for each instant and point, (n_rows,) each:
    grouped by instant, sorted by x, shapes and loads checked. `notes` come first in its notes.
    """
    instants, source_in_words = _instants_of_rows(columns)
    points_of_instants = np.unique(instants, return_counts=True)[1]
    if np.any(points_of_instants != points_of_instants[0]):
        first_odd = int(np.flatnonzero(points_of_instants != points_of_instants[0])[0])
        raise InputError(
            f"{source}: instant {first_odd + 1} (by {source_in_words}) has"
            f" {points_of_instants[first_odd]} points and the first has"
            f" {points_of_instants[0]}: every instant needs the same points, with zeros where"
            " nothing touches"
        )
    rows_by_instant = np.argsort(instants, kind="stable")
    value_grids: dict[str, Array] = {
        name: values[rows_by_instant].reshape(len(points_of_instants), -1)
        for name, values in columns.items()
        if name != "frame"
    }
    indices_by_x = np.argsort(value_grids["x"], axis=1, kind="stable")
    value_grids = {
        name: np.take_along_axis(values, indices_by_x, axis=1)
        for name, values in value_grids.items()
    }
    series: dict[str, Array | None] = {}
    for name in ("time", "normal_load", "tangential_load"):
        values = value_grids.get(name)
        if values is not None:
            # what a factor made infinite is refused with all that is not finite
            with np.errstate(invalid="ignore"):
                odd_rows = np.flatnonzero(np.ptp(values, axis=1) > 1e-9 * np.max(np.abs(values)))
            if len(odd_rows):
                row = values[odd_rows[0]]
                raise InputError(
                    f"{source}: {name} goes from {row.min():.6g} to {row.max():.6g} within instant"
                    f" {odd_rows[0] + 1} (by {source_in_words})"
                )
        series[name] = None if values is None else values[:, 0]
    if mapping.times is not None:
        series["time"] = stated_times(source, mapping, len(points_of_instants))
    if np.any(np.diff(instants) < 0):
        notes = [*notes, "the rows were not in the order of the instants and were sorted"]
    if np.any(np.diff(indices_by_x, axis=1) < 0):
        notes = [*notes, "the points were not in the order of x and were sorted"]
    fields = {name: value_grids.get(name) for name in ("pressure", "shear", "slip")}
    return surface_result(source, mapping.code, value_grids["x"], dict(fields), dict(series), notes)


def _instants_of_rows(columns: dict[Quantity, Array]) -> tuple[NDArray[np.intp], str]:
    """Number of the instant to which each row of a table belongs, from 0 on, (n_rows,), and the
    name of the column by which instants were told apart: "time", "frame", "the loads", or
    "nothing". `columns` holds the values of each quantity, (n_rows,) each.
    """
    for key in ("time", "frame"):
        if key in columns:
            _, instants = np.unique(columns[key], return_inverse=True)
            return instants, key
    if "normal_load" not in columns:
        return np.zeros(len(columns["x"]), dtype=np.intp), "nothing"
    normal_load = columns["normal_load"]
    loads = np.column_stack([normal_load, columns.get("tangential_load", normal_load)])
    is_new = np.any(np.diff(loads, axis=0) != 0, axis=1)
    return np.concatenate([[0], np.cumsum(is_new)]), "the loads"


class _Head(NamedTuple):
    """What a column's name says."""

    quantity: Quantity | None
    frame: float | None  # None: not said
    is_time: bool  # whether that figure is a time


def _quantity_of_heading(name: str, mapping: Mapping) -> _Head:
    """What the heading of a column says: its quantity (None if it is none that is read), the number
    of a frame or its time where one follows ('pressure t=0.5'), and whether that number is a time.
    `mapping` states columns, units and signs of the file.
    """

    def quantity_of(base: str) -> Quantity | None:
        for quantity in _FIELDS:
            stated_column = getattr(mapping.columns, quantity)
            aliases = ALIASES[quantity] if stated_column is None else (stated_column,)
            if plain(base) in map(plain, aliases):
                return quantity
        return None

    tag_match = _TAGGED.match(name.strip())
    quantity = quantity_of(tag_match["base"]) if tag_match else None
    if tag_match is None or quantity is None:
        return _Head(quantity_of(name), None, False)
    word = plain(tag_match["word"] or "")
    is_time = word in ("time", "t", "steptime", "totaltime")
    if not word and "." in tag_match["figure"]:
        is_time = True
    return _Head(quantity, float(tag_match["figure"]), is_time)


def _columns_of_frames(
    source: str, table: TextTable, mapping: Mapping
) -> tuple[dict[Quantity, Array], list[str]] | None:
    """Read a table whose frames (instants) stand side by side, as groups of columns: a column for
    each quantity, the frames one below the other, and a note. None where the names of the columns
    don't look like that.

    Each frame has a pressure and perhaps a shear, a slip and places of its own. Its number or time
    stands in the names, or the frames are taken in the order of the columns.
    """
    headings = [_quantity_of_heading(name, mapping) for name in table.names]
    values_of: dict[Quantity, dict[float, Array]] = {quantity: {} for quantity in _FIELDS}
    for column_number, heading in enumerate(headings):
        if heading.quantity is None:
            continue
        values_by_frame = values_of[heading.quantity]
        frame = float(len(values_by_frame)) if heading.frame is None else heading.frame
        if frame in values_by_frame:
            raise InputError(
                f"{source}: two columns hold {heading.quantity} of the same frame; leave one out or"
                " rename it"
            )
        values_by_frame[frame] = converted(
            mapping, heading.quantity, table.values[:, column_number]
        )
    frames = sorted(values_of["pressure"])
    has_frame_in_name = any(
        heading.quantity == "pressure" and heading.frame is not None for heading in headings
    )
    if not values_of["x"] or (len(frames) < 2 and not has_frame_in_name):
        return None
    if len(values_of["x"]) == 1:
        (x,) = values_of["x"].values()
        values_of["x"] = dict.fromkeys(frames, x)
    columns = {}
    for quantity, values_by_frame in values_of.items():
        if not values_by_frame:
            continue
        missing_frames = sorted(set(frames) ^ values_by_frame.keys())
        if missing_frames:
            raise InputError(
                f"{source}: frame {missing_frames[0]:g} has no {quantity}, or no pressure; every"
                " frame needs both pressure and shear"
            )
        columns[quantity] = np.concatenate([values_by_frame[frame] for frame in frames])
    quantity_of_frames: Quantity = (
        "time" if any(heading.is_time for heading in headings) else "frame"
    )
    columns[quantity_of_frames] = converted(
        mapping, quantity_of_frames, np.repeat(frames, len(table.values))
    )
    has_number_in_name = any(
        heading.quantity is not None and heading.frame is not None for heading in headings
    )
    order_in_words = (
        "by the figures in their names" if has_number_in_name else "in the order of the columns"
    )
    return columns, [
        f"{len(frames)} frames were found beside each other, told apart {order_in_words}"
    ]
