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
from numpy.typing import ArrayLike, NDArray

from reports.scoring.abaqus import is_field_report, read_field_report
from reports.scoring.mapping import (
    ColumnQuantity,
    Mapping,
    conversion_in_words,
    converted_values,
    name_of_column,
    stated_times,
)
from reports.scoring.surface import SurfaceResult, surface_result
from scenes import InputError
from scenes.array_types import Array
from scenes.column_names import ALIASES, normalised_name
from scenes.measured import layout_in_words
from scenes.text_tables import TableKind, TextTable, text_table

_TABLE_SUFFIXES = (".csv", ".txt", ".rpt")
# A solution of this program.
SOLUTION_SUFFIX = ".nc"
# Suffix -> module and function, each read(path, mapping) -> SurfaceResult; loaded when a file asks
# for it.
READER_BY_SUFFIX: dict[str, str] = {
    **dict.fromkeys(_TABLE_SUFFIXES, "reading:read_table"),
    ".frd": "calculix:read_results",
    ".dat": "calculix:read_printed",
    **dict.fromkeys((".vtu", ".vtk", ".pvd"), "fields:read_fields"),
}
_QUANTITIES_OF_TABLES: tuple[ColumnQuantity, ...] = (
    "time",
    "frame",
    "normal_load",
    "tangential_load",
    "x",
    "pressure",
    "shear",
    "slip",
)
_QUANTITIES_OF_POINTS: tuple[ColumnQuantity, ...] = ("x", "pressure", "shear", "slip")
_KNOWN_HEADINGS = {
    normalised_name(alias) for name in _QUANTITIES_OF_TABLES for alias in ALIASES[name]
}
# "CPRESS Frame 12", "CSHEAR1 at t=0.5", "p_3": the name, then perhaps a word for what the figure
# counts, then the figure. A run of signs belongs to no name and is never tried in parts: 3,000
# brackets as a name took 8 s, with the cube of their number.
_HEADING_WITH_NUMBER = re.compile(
    r"^(?P<base>.+?)(?<![\s_:@,.;\-(\[])[\s_:@,.;\-(\[]++(?:at\s+)?"
    r"(?P<word>step[\s_]?time|total[\s_]?time|time|frame|increment|inc|f|t|step)?"
    r"[\s_:=#]*(?P<figure>\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)\s*s?[)\]]?$",
    re.IGNORECASE,
)


def read_result(path: Path, mapping: Mapping) -> SurfaceResult:
    """The external result in a file: tractions on points of the contact surface. They are in the
    scene's units and this program's signs as far as the mapping states those of the file. The
    suffix of the file decides which reader takes it.

    Raises
    ------
    InputError
        One sentence: no such file, no reader for it, or what its reader found.
    """
    if not path.exists():
        raise InputError(f"{path}: there is no such file")
    reader_name = READER_BY_SUFFIX.get(path.suffix.lower())
    if reader_name is None:
        raise InputError(
            f"{path}: no reader for {path.suffix or 'a file without suffix'!r}; it reads"
            f" {', '.join(sorted(READER_BY_SUFFIX))}, .nc"
        )
    # such as "calculix:read_results"
    module, function = reader_name.split(":")
    reader = getattr(import_module(f"reports.scoring.{module}"), function)
    return cast(SurfaceResult, reader(path, mapping))


def read_table(path: Path, mapping: Mapping) -> SurfaceResult:
    """The external result in a text table with a line of names: one row for each instant and point;
    or one row for each point, with columns for each frame (the values at one instant).

    Instants differ by time, else by a number of the frame, else by the loads. `mapping` states
    columns, units and signs of the file. A report of Abaqus (.rpt) is read too.

    Raises
    ------
    InputError
        One sentence that names the file, the line or column, and what to do.
    """
    source = str(path)
    if path.suffix.lower() == ".rpt" and path.is_file() and is_field_report(path):
        return _surface_of_rows(source, mapping, *read_field_report(path, mapping))
    # names of the columns, and values (n_rows, n_columns); TableKind: which headings are expected,
    # and words for messages
    table = text_table(
        path,
        kind=TableKind(
            role_of_file="the result",
            advice_on_size="write the contact surface alone, and fewer instants",
            is_expected_heading=lambda name: (
                # quantity, or None; number of a frame
                _read_heading(name, mapping).quantity is not None
                or normalised_name(name) in _KNOWN_HEADINGS
            ),
        ),
    )
    # frames beside each other; None where the headings don't look like that
    columns_and_notes = _columns_of_frames(source, table, mapping)
    if columns_and_notes is not None:
        columns, notes = columns_and_notes
        # quantity of each column, None where it is not read
        quantities = [_read_heading(name, mapping).quantity for name in table.names]
    else:
        columns = {}
        notes = []
        quantity_by_name: dict[str, ColumnQuantity] = {}
        for quantity in _QUANTITIES_OF_TABLES:
            is_needed = quantity in ("x", "pressure")
            name = name_of_column(mapping, quantity, table.names, source, is_needed=is_needed)
            if name is not None:
                columns[quantity] = converted_values(mapping, quantity, table.column(name))
                quantity_by_name[name] = quantity
        quantities = [quantity_by_name.get(name) for name in table.names]
    surface = _surface_of_rows(source, mapping, columns, notes)
    # for the page: what each column was read as, and where outliers stand in the file
    surface = _with_words_on_columns(surface, table, mapping, quantities)
    return _with_places_of_outliers(surface, table, mapping)


def _with_words_on_columns(
    surface: SurfaceResult,
    table: TextTable,
    mapping: Mapping,
    quantities: Sequence[ColumnQuantity | None],
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
    # pairs (subject, words): first the layout of the table
    read_as = layout_in_words(Path(surface.source), table)
    for name, quantity in zip(table.names, quantities, strict=True):
        column_in_words = "not read" if quantity is None else conversion_in_words(mapping, quantity)
        read_as.append((f"column {name}", column_in_words))
    return replace(surface, read_as=tuple(read_as))


def _with_places_of_outliers(
    surface: SurfaceResult, table: TextTable, mapping: Mapping
) -> SurfaceResult:
    """An external result with line, column and written number in the file for each of its outliers.

    An outlier is a single value of a field `quantity` that stands out of all others, with its
    `value` and its `place` in words. It is found again in the table by its magnitude, since all
    values of a quantity were multiplied by one factor on reading. `mapping` states columns, units
    and signs of the file.
    """
    if not surface.outliers:
        return surface
    magnitudes_in_table = np.abs(table.values)
    outliers = []
    for outlier in surface.outliers:
        magnitudes_read = np.abs(getattr(surface, outlier.quantity))
        columns_of_quantity = [
            column
            for column, heading in enumerate(table.names)
            if _read_heading(heading, mapping).quantity == outlier.quantity
        ]
        magnitudes_written = magnitudes_in_table[:, columns_of_quantity]
        factor = float(magnitudes_read.max() / magnitudes_written.max())
        difference = np.abs(magnitudes_written * factor - abs(outlier.value))
        row, index_among_columns = np.unravel_index(np.argmin(difference), difference.shape)
        column = columns_of_quantity[index_among_columns]
        outliers.append(
            replace(
                outlier,
                place=(
                    f"line {table.line_numbers[row]}, column {table.names[column]!r}"
                    f" ({outlier.place})"
                ),
                number_in_file=float(table.values[row, column]),
            )
        )
    return replace(surface, outliers=tuple(outliers))


def _surface_of_rows(
    source: str, mapping: Mapping, columns: dict[ColumnQuantity, Array], notes: list[str]
) -> SurfaceResult:
    """An external result from columns with one row for each instant and point, (n_rows,) each:
    grouped by instant, sorted by x, shapes and loads checked. `notes` come first in its notes.

    `columns` holds x, pressure and, as far as the file has them, shear, slip, time, frame and
    loads. InputError where instants have different numbers of points, or a time or load changes
    within an instant.
    """
    # number of the instant of each row, and the column by which they differ
    instant_of_row, instants_by = _instants_of_rows(columns)
    n_instants = _number_of_equal_instants(source, instant_of_row, instants_by)
    rows_by_instant = np.argsort(instant_of_row, kind="stable")
    # (n_instants, n_points) of each quantity
    value_grids: dict[str, Array] = {
        name: values[rows_by_instant].reshape(n_instants, -1)
        for name, values in columns.items()
        if name != "frame"
    }
    indices_by_x = np.argsort(value_grids["x"], axis=1, kind="stable")
    value_grids = {
        name: np.take_along_axis(values, indices_by_x, axis=1)
        for name, values in value_grids.items()
    }
    series: dict[str, ArrayLike | None] = {}
    for name in ("time", "normal_load", "tangential_load"):
        series[name] = None
        if name in value_grids:
            series[name] = _one_value_an_instant(source, name, value_grids[name], instants_by)
    if mapping.times is not None:
        series["time"] = stated_times(source, mapping, n_instants)
    if np.any(np.diff(instant_of_row) < 0):
        notes = [*notes, "the rows were not in the order of the instants and were sorted"]
    if np.any(np.diff(indices_by_x, axis=1) < 0):
        notes = [*notes, "the points were not in the order of x and were sorted"]
    fields: dict[str, ArrayLike | None] = {
        name: value_grids.get(name) for name in ("pressure", "shear", "slip")
    }
    return surface_result(source, mapping.code, value_grids["x"], fields, series, notes)


def _number_of_equal_instants(
    source: str, instant_of_row: NDArray[np.intp], instants_by: str
) -> int:
    """How many instants a table of a result has; InputError, naming the file `source`, where they
    have different numbers of points.

    `instant_of_row` (n_rows,) is the number of each row's instant, from 0 on; `instants_by` names
    the column by which instants were told apart.
    """
    point_counts = np.unique(instant_of_row, return_counts=True)[1]
    instants_with_other_count = np.flatnonzero(point_counts != point_counts[0])
    if len(instants_with_other_count):
        other_instant = int(instants_with_other_count[0])
        raise InputError(
            f"{source}: instant {other_instant + 1} (by {instants_by}) has"
            f" {point_counts[other_instant]} points and the first has"
            f" {point_counts[0]}: every instant needs the same points, with zeros where"
            " nothing touches"
        )
    return len(point_counts)


def _one_value_an_instant(source: str, name: str, values: Array, instants_by: str) -> Array:
    """Time or load of each instant of a result, (n_instants,), from its values at all points,
    (n_instants, n_points). InputError, naming the file `source` and the series `name`, where a
    value changes within an instant. `instants_by` names the column by which instants were told
    apart.
    """
    # values that a factor made infinite are refused later, with all that is not finite
    with np.errstate(invalid="ignore"):
        ranges = np.ptp(values, axis=1)
        changing_instants = np.flatnonzero(ranges > 1e-9 * np.max(np.abs(values)))
    if len(changing_instants):
        instant = changing_instants[0]
        raise InputError(
            f"{source}: {name} goes from {values[instant].min():.6g} to"
            f" {values[instant].max():.6g} within instant {instant + 1} (by {instants_by})"
        )
    return values[:, 0]


def _instants_of_rows(columns: dict[ColumnQuantity, Array]) -> tuple[NDArray[np.intp], str]:
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
    begins_instant = np.any(np.diff(loads, axis=0) != 0, axis=1)
    return np.concatenate([[0], np.cumsum(begins_instant)]), "the loads"


class _Heading(NamedTuple):
    """The content of a column's heading.

    Attributes
    ----------
    quantity
        None where it is none that is read
    frame
        number of the frame, or its time; None where none is stated
    is_time
        whether this number is a time
    """

    quantity: ColumnQuantity | None
    frame: float | None
    is_time: bool


def _read_heading(name: str, mapping: Mapping) -> _Heading:
    """Read the heading of a column of a table of tractions: its quantity (None if it is none that
    is read), the number of a frame or its time where one follows ('pressure t=0.5'), and whether
    that number is a time. `mapping` states names of columns.
    """

    def quantity_of(base: str) -> ColumnQuantity | None:
        """The quantity with this name, by the mapping, else by known names (ALIASES): x, pressure,
        shear or slip.
        """
        for quantity in _QUANTITIES_OF_POINTS:
            stated_column = getattr(mapping.columns, quantity)
            aliases = ALIASES[quantity] if stated_column is None else (stated_column,)
            if normalised_name(base) in map(normalised_name, aliases):
                return quantity
        return None

    # a name, perhaps a word such as "frame" or "time", then a number
    match_with_number = _HEADING_WITH_NUMBER.match(name.strip())
    quantity = quantity_of(match_with_number["base"]) if match_with_number else None
    if match_with_number is None or quantity is None:
        return _Heading(quantity_of(name), frame=None, is_time=False)
    written_number = match_with_number["figure"]
    word_before_number = normalised_name(match_with_number["word"] or "")
    is_time = word_before_number in ("time", "t", "steptime", "totaltime")
    if not word_before_number and "." in written_number:
        is_time = True
    return _Heading(quantity, float(written_number), is_time)


def _columns_of_frames(
    source: str, table: TextTable, mapping: Mapping
) -> tuple[dict[ColumnQuantity, Array], list[str]] | None:
    """Read a table in which the frames (the values at one instant) stand beside each other as
    groups of columns. Returns the values of each quantity with the frames one below the other,
    (n_frames n_points,), and a note. None where the headings of the columns don't look like that.

    Each frame has a pressure and perhaps a shear, a slip and an x of its own. Its number or time
    stands in the headings, or the frames are taken in the order of the columns. InputError where a
    frame has a quantity twice, or lacks one that other frames have. `mapping` states columns, units
    and signs.
    """
    # of each column: its quantity, and the frame's number or time, None where none is stated
    headings = [_read_heading(name, mapping) for name in table.names]
    frames_of_quantity = _values_by_quantity_and_frame(source, table, mapping, headings)
    # numbers of the frames, or their times
    numbers_of_frames = sorted(frames_of_quantity["pressure"])
    has_frame_in_name = any(
        heading.quantity == "pressure" and heading.frame is not None for heading in headings
    )
    if not frames_of_quantity["x"] or (len(numbers_of_frames) < 2 and not has_frame_in_name):
        return None
    if len(frames_of_quantity["x"]) == 1:
        (x,) = frames_of_quantity["x"].values()
        frames_of_quantity["x"] = dict.fromkeys(numbers_of_frames, x)

    # frames one below the other, (n_frames n_points,) of each quantity
    columns = {
        quantity: _frames_below_each_other(source, quantity, numbers_of_frames, values_by_frame)
        for quantity, values_by_frame in frames_of_quantity.items()
        if values_by_frame
    }
    quantity_of_frames: ColumnQuantity = "frame"
    if any(heading.is_time for heading in headings):
        quantity_of_frames = "time"
    columns[quantity_of_frames] = converted_values(
        mapping, quantity_of_frames, np.repeat(numbers_of_frames, len(table.values))
    )
    has_number_in_name = any(
        heading.quantity is not None and heading.frame is not None for heading in headings
    )
    order_in_words = (
        "by the figures in their names" if has_number_in_name else "in the order of the columns"
    )
    return columns, [
        f"{len(numbers_of_frames)} frames were found beside each other, told apart {order_in_words}"
    ]


def _values_by_quantity_and_frame(
    source: str, table: TextTable, mapping: Mapping, headings: Sequence[_Heading]
) -> dict[ColumnQuantity, dict[float, Array]]:
    """Quantity -> number or time of a frame -> values (n_points,) in the scene's unit and this
    program's sign. Frames without a number are counted from 0 in the order of the columns.
    InputError, naming the file `source`, where two columns hold one quantity of the same frame.

    `headings` state for each column of the table its quantity, None for a column that is not read,
    and the frame's number or time, None where it states none.
    """
    frames_of_quantity: dict[ColumnQuantity, dict[float, Array]] = {
        quantity: {} for quantity in _QUANTITIES_OF_POINTS
    }
    for column_number, heading in enumerate(headings):
        if heading.quantity is None:
            continue
        values_by_frame = frames_of_quantity[heading.quantity]
        frame = float(len(values_by_frame)) if heading.frame is None else heading.frame
        if frame in values_by_frame:
            raise InputError(
                f"{source}: two columns hold {heading.quantity} of the same frame; leave one out or"
                " rename it"
            )
        values_by_frame[frame] = converted_values(
            mapping, heading.quantity, table.values[:, column_number]
        )
    return frames_of_quantity


def _frames_below_each_other(
    source: str,
    quantity: ColumnQuantity,
    frames: Sequence[float],
    values_by_frame: dict[float, Array],
) -> Array:
    """Values of a quantity in all frames, one below the other, (n_frames n_points,). InputError,
    naming the file `source`, where its frames are not those of the pressure, `frames`.
    """
    missing_frames = sorted(set(frames) ^ values_by_frame.keys())
    if missing_frames:
        raise InputError(
            f"{source}: frame {missing_frames[0]:g} has no {quantity}, or no pressure; every"
            " frame needs both pressure and shear"
        )
    return np.concatenate([values_by_frame[frame] for frame in frames])
