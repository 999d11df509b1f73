"""Measured tables: rows of numbers from lists, or columns of text files in the units of the scene;
fewer rows for a long record.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import (
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from scenes.array_types import Array
from scenes.arrays import LARGEST, real_numbers
from scenes.errors import InputError, RowError, shown
from scenes.frozen import Frozen
from scenes.unit_words import Kind, short_unit_in, unit_factor, unit_in

if TYPE_CHECKING:
    from scenes.text_tables import TextTable


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of finite numbers as a read-only array (n_rows, n_columns); in a scene file, a list of
    lists.

    >>> Table.of([[0, 0], [1, 2]]).values.shape
    (2, 2)
    """

    values: Array

    @classmethod
    def of(cls, rows: ArrayLike | Table) -> Table:
        """Make a table from lists, an array or another table: rows of equally many finite numbers;
        ValueError with the first row that is none.
        """
        try:
            values = (
                rows.values
                if isinstance(rows, Table)
                else np.array(real_numbers(rows, "the table of rows"))
            )
        except InputError:
            values = np.empty(0)
        if values.ndim != 2 or not len(values):
            raise ValueError("rows of equally many numbers are needed")
        rule = f"is not all finite numbers of at most {LARGEST:g}"
        RowError.refuse(
            ~(np.abs(values) <= LARGEST).all(axis=1),
            lambda row: f"{shown(values[row].tolist())} {rule}",
        )
        values.flags.writeable = False
        return cls(values)

    def __eq__(self, table: object) -> bool:
        return isinstance(table, Table) and np.array_equal(self.values, table.values)

    def __hash__(self) -> int:
        return hash((self.values.shape, self.values.tobytes()))

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        return f"Table({len(self.values)} rows of {self.values.shape[1]})"

    @classmethod
    def of_a_file(cls) -> Table:
        """What stands in place of rows until a file is read; without a row."""
        return cls(np.empty((0, 0)))

    @classmethod
    def __get_pydantic_core_schema__(
        cls, _source: Any, _handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            cls.of,
            serialization=core_schema.plain_serializer_function_ser_schema(
                lambda table: table.values.tolist()
            ),
        )

    @classmethod
    def __get_pydantic_json_schema__(
        cls, _schema: CoreSchema, _handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}


ReadAs = tuple[tuple[str, str], ...]
# Keys that say how a file is read.
READING = (
    "columns",
    "units",
    "thickness",
    "scale",
    "zero",
    "sign",
    "interval",
    "constant_normal_load",
)
# What each of them is, for descriptions.
COLUMNS = "headings or numbers (from 1) of columns without a usual name"
UNITS = "units of columns whose headings state none; turned into those of the scene"
SCALE = "factors of the columns, such as a calibration"
ZERO = "numbers that mean zero: taken off first, in the units of the file"
READ_AS = "how the file was read, found and assumed; written by the reader"


LIKELY_UNITS = {"length": "mm", "load": "N", "stress": "MPa", "angle": "rad"}
"""A unit of each kind, for a sentence that asks for it."""


@dataclass(frozen=True)
class ColumnUnit:
    """The unit of a column, as it was understood.

    Attributes
    ----------
    word
        as it stands in the file or was stated; empty where there is none
    source
        "in its heading", "in the line of units", or "stated"
    factor
        from the numbers of the file to the unit of the scene; 1 where no unit is known
    per_length
        whether it is a force per length
    fault
        why the word is no unit that can be used; empty where it can
    words
        all this for the user; empty where the unit of a time is not stated
    """

    word: str
    source: str
    factor: float
    per_length: bool
    fault: str
    words: str

    @property
    def known(self) -> bool:
        """Whether there is a unit, and it was understood."""
        return bool(self.word) and not self.fault


def unit_of_column(
    table: TextTable, column: int, kind: Kind, units: str, stated: str | None = None
) -> ColumnUnit:
    """Find the unit of a column of a text table, and its factor to the units of the scene.

    It is the `stated` one, else the one in the line of units or in the heading of the column.
    Without one, or with an unknown one, the factor is 1 and the description says so.

    Parameters
    ----------
    table
        columns, headings and units of the file
    column
        number of the column, from 0
    kind
        what its unit must be, such as a length
    units
        units of the scene, such as "N, mm, MPa"
    stated
        unit that the user states for the column, if any
    """
    unit_name = stated or table.units[column] or short_unit_in(table.headings[column], kind)
    source = "in its heading"
    if stated:
        source = "stated"
    elif unit_name and unit_name not in (
        unit_in(table.headings[column])[1],
        short_unit_in(table.headings[column], kind),
    ):
        source = "in the line of units"
    if not unit_name:
        remark = "no unit stated: taken to be in that of the scene"
        return ColumnUnit("", source, 1.0, False, "", "" if kind == "time" else remark)
    try:
        factor, per_length = unit_factor(unit_name, kind, units)
    except ValueError as reason:
        remark = f"{unit_name!r} {source} is no unit that is known: taken as it stands"
        return ColumnUnit(unit_name, source, 1.0, False, str(reason), remark)
    remark = f"{unit_name} ({source}), times {factor:.9g}"
    return ColumnUnit(unit_name, source, factor, per_length, "", remark)


def layout_in_words(path: Path, table: TextTable) -> list[tuple[str, str]]:
    """Describe for the user how numbers were found in a text file, as (what, how): rows, separator,
    decimal sign, encoding, lines that were left out.
    """
    layout = [
        ("file", f"{path.name}: {len(table.lines):,} rows from line {table.lines[0]} on"),
        ("columns separated by", table.separator),
        ("decimal sign", table.decimal),
    ]
    if not table.encoding.startswith("UTF-8"):
        layout.append(("characters", table.encoding))
    if table.skipped:
        layout.append(("lines above the headings", f"{table.skipped} skipped"))
    layout += [("left out", words) for words in table.left_out]
    return layout


class _Reading(NamedTuple):
    """How a column becomes numbers of the scene: (number - zero) x factor; and this in words."""

    zero: float
    factor: float
    unit_known: bool
    words: str


class FromFile(Frozen):
    """Keys of which one, `table`, is rows of numbers that may stand in a text `file` instead,
    relative to the scene file.

    A number of the scene is sign x scale x unit x (number of the file - zero) / thickness.
    """

    table: ClassVar[str]
    quantities: ClassVar[dict[str, Kind]]
    further: ClassVar[dict[str, Kind]] = {}
    """Keys that are lists, an entry for each row, which may be columns of the file too, where
    `columns` names them.
    """

    kind: str
    file: str | None
    read_as: ReadAs | None

    @property
    def column_kinds(self) -> dict[str, Kind]:
        """The columns that a file must have, and what each is."""
        return self.quantities

    @model_validator(mode="after")
    def _read(self, validation: ValidationInfo) -> Self:
        """Read measured rows from the file that the scene names, unless they are stated in the
        scene itself: each column is converted into the scene's units.

        The key `read_as` then describes, for the user, how each column was read. The context of
        the `validation` has the folder of the scene file and the units of the scene.

        Raises
        ------
        InputError
            For a file or a unit that is not understood, and for a quantity stated twice.
        """
        if self.table in self.model_fields_set:
            return self
        if self.file is None:
            raise PydanticCustomError(
                "key_missing", "the key {key} is missing", {"key": self.table}
            )
        path = _folder(validation) / self.file
        units = (validation.context or {}).get("units")
        if not isinstance(units, str):
            units = _DEFAULT_UNITS
        columns = getattr(self, "columns", None)
        column_names = self._named(columns)
        kinds = self.column_kinds | {name: self.further[name] for name in column_names}
        table = self._table_of(path, tuple(kinds), columns)
        reading_words = layout_in_words(path, table)
        is_converted = False
        for column, (name, kind) in enumerate(kinds.items()):
            column_reading = self._reading(path, table, column, name, kind, units)
            is_converted = is_converted or (column_reading.unit_known and kind != "time")
            # Numbers that are not finite are refused later, with their row.
            with np.errstate(over="ignore", invalid="ignore"):
                table.values[:, column] -= column_reading.zero
                table.values[:, column] *= column_reading.factor
            reading_words.append((name, column_reading.words))
        reading_words += self._of_no_column()
        if table.unused:
            headings = ", ".join(map(repr, table.unused[:_MOST_HEADINGS]))
            rest_of_names = f" and {len(table.unused) - _MOST_HEADINGS} more" * (
                len(table.unused) > _MOST_HEADINGS
            )
            reading_words.append(("not read", f"{headings}{rest_of_names}"))
        if is_converted:
            reading_words.append((SCENE_UNITS, units))
        stated_twice = [name for name in column_names if getattr(self, name) is not None]
        if stated_twice:
            raise InputError(
                f"{self.file}: {stated_twice[0]} is a column of the file and stated beside it:"
                " leave one out"
            )
        values = Table.of(self._with_no_columns(table.values)).values
        n_columns = values.shape[1] - len(column_names)
        keys_read: dict[str, Any] = {
            self.table: Table.of(values[:, :n_columns]),
            "read_as": tuple(reading_words),
        }
        for column, name in enumerate(column_names):
            keys_read[name] = tuple(values[:, n_columns + column].tolist())
        for name, value in keys_read.items():
            object.__setattr__(self, name, value)
        self.model_fields_set.update(keys_read)
        return self

    def _table_of(self, path: Path, columns: tuple[str, ...], stated: Frozen | None) -> TextTable:
        """The columns of the file.

        Raises
        ------
        InputError
            As the reader of tables.
        """
        from scenes.text_tables import text_table  # only a scene that names a file needs it

        return text_table(path, columns, stated=_stated_columns(stated))

    def _of_no_column(self) -> list[tuple[str, str]]:
        """The quantities that stand in the scene in place of a column, in words."""
        return []

    def _with_no_columns(self, values: Array) -> Array:
        """Rows (n, m) of the columns that are read, with the quantities that are no column."""
        return values

    def _reading(
        self, path: Path, table: TextTable, column: int, name: str, kind: Kind, units: str
    ) -> _Reading:
        """How one column of a text file is turned into numbers of the scene: zero, factor, whether
        its unit is known, and a description of all that for the user.

        Parameters
        ----------
        path
            of the file, for messages
        table
            the file's columns, headings and units
        column
            number of the column in the `table`, from 0
        name
            quantity that it holds, such as "P"
        kind
            kind of its unit, such as "load" or "length"
        units
            units of the scene, such as "N, mm, MPa"

        Raises
        ------
        InputError
            For a unit that is not understood, for forces without a thickness, and for forces
            per length with one.
        """
        heading = table.headings[column]
        is_clock = bool(table.clock_start) and kind == "time"
        unit = self._unit_of_reading(path, table, column, name, kind, units)
        thickness = getattr(self, "thickness", None) if kind == "load" else None
        if unit.known and kind == "load":
            _check_thickness(path, name, unit, thickness)
        scale = _stated_columns(getattr(self, "scale", None)).get(name)
        zero = _stated_columns(getattr(self, "zero", None)).get(name)
        sign = _stated_columns(getattr(self, "sign", None)).get(name, 1)
        phrases = [repr(heading) if table.head else heading]
        if is_clock:
            phrases.append(f"times of day: seconds since {table.clock_start}")
        elif unit.words:
            phrases.append(unit.words)
        if zero is not None:
            phrases.append(f"zero at {zero:.9g} of the file")
        if scale is not None:
            phrases.append(f"times {scale:.9g} (scale)")
        if thickness is not None:
            phrases.append(f"over the thickness {thickness:.9g}")
        if sign < 0:
            phrases.append("sign turned")
        # The quotient is formed first: the order decides about the last digit.
        factor = unit.factor * ((1.0 if scale is None else scale) * sign / (thickness or 1.0))
        return _Reading(0.0 if zero is None else zero, factor, unit.known, ", ".join(phrases))

    def _unit_of_reading(
        self, path: Path, table: TextTable, column: int, name: str, kind: Kind, units: str
    ) -> ColumnUnit:
        """Unit of one column of a text file, as the user states it or as the file does, with its
        factor to the units of the scene.

        The arguments are those of the column's reading: file, table, number and quantity of the
        column, kind of unit, units of the scene.

        Raises
        ------
        InputError
            For a stated unit that is not understood; for one of the file, unless it changes no
            result (times, moments) or the user states a scale.
        """
        stated_units = _stated_columns(getattr(self, "units", None))
        scales = _stated_columns(getattr(self, "scale", None))
        if table.clock_start and kind == "time":  # times of day have been turned into seconds
            stated_units.pop(name, None)
        unit = unit_of_column(table, column, kind, units, stated_units.get(name))
        if unit.fault and name in stated_units:
            raise InputError(f"units.{name}: {unit.fault}")
        # The unit of time changes no result, moments are not converted, and a stated scale turns
        # volts into loads.
        if unit.fault and kind not in ("time", "moment") and name not in scales:
            advice_for_loads = ""
            if kind == "load":
                advice_for_loads = (
                    ": to loads per unit thickness, or to forces beside the key thickness"
                )
            raise InputError(
                f"{path}: the heading {table.headings[column]!r} of {name} has {unit.word!r} where"
                f" a unit stands: {unit.fault}; state the unit of the numbers, such as units ="
                f" {{{name} = {LIKELY_UNITS[kind]!r}}}, or their factor by scale{advice_for_loads}"
            )
        return unit

    @classmethod
    def _named(cls, columns: Frozen | None) -> list[str]:
        """Which of the further columns a table of `columns` names."""
        return [name for name in _stated_columns(columns) if name in cls.further]

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """The keys of this table that its user gave, with some changed; not checked yet.

        Where the file, or how it is read, changes, the rows that were read from the old one are
        left out. Where the rows change, the file and all keys of reading are left out. `changes`
        maps keys to new values.
        """
        keys = super().merged(changes)
        columns_read = self._named(getattr(self, "columns", None))
        if self.table in changes and "file" not in changes:
            for key in ("file", "read_as", *READING, *(set(columns_read) - changes.keys())):
                keys.pop(key, None)
        elif (
            self.table not in changes
            and keys.get("file") is not None
            and not changes.keys().isdisjoint(("file", *READING))
        ):
            for key in (self.table, "read_as", *(set(columns_read) - changes.keys())):
                keys.pop(key, None)
        return keys

    @abc.abstractmethod
    def check_rows(self) -> None:
        """RowError for the first row that is at fault."""

    @model_validator(mode="after")
    def _check(self, validation: ValidationInfo) -> Self:
        """Refuse rows that are no valid measurement, with the line of the file that they come from,
        and keys on how a file is read where no file is named (ValueError).
        """
        try:
            self.check_rows()
        except RowError as fault:
            path = _folder(validation) / (self.file or "")
            place = f"{self.table}, row {fault.row + 1}"
            if self.file is not None and path.is_file():  # where the rows came from
                from scenes.text_tables import text_table

                columns = _stated_columns(getattr(self, "columns", None))
                table = text_table(path, tuple(self.column_kinds), stated=columns)
                place = f"{path}, line {table.lines[fault.row]}"
            raise ValueError(f"{place}: {fault.rule}") from fault
        unused_keys = [key for key in READING if getattr(self, key, None) is not None]
        if self.file is None and unused_keys:
            raise ValueError(
                f"{unused_keys[0]} says how a file is read, and `{self.table}` stand in the units"
                " of the scene: leave it out"
            )
        return self


def _check_thickness(path: Path, name: str, unit: ColumnUnit, thickness: float | None) -> None:
    """Refuse a column of forces where the scene states no thickness to divide them by, and one of
    forces per length where it does (InputError).

    `name` is the quantity of the column, `thickness` that of the contact out of the plane [length].
    """
    if unit.per_length != (thickness is not None):
        return
    fault_text = (
        "a force, and loads are per unit thickness: state the key thickness, the length of"
        " the contact out of the plane, by which it is divided"
    )
    if unit.per_length:
        fault_text = "per length already: leave out the key thickness"
    raise InputError(f"{path}: {name} is in {unit.word} ({unit.source}), {fault_text}")


def _folder(validation: ValidationInfo) -> Path:
    """Where the scene file lies."""
    return Path((validation.context or {}).get("folder", "."))


# Headings in a sentence.
_MOST_HEADINGS = 12
# Of the library; where nothing else is stated.
_DEFAULT_UNITS = "N, mm, MPa"
SCENE_UNITS = "units of the scene"
"""Key of `read_as`: into which units the columns of a file were turned; left out where none was."""


def _stated_columns(table: Frozen | None) -> dict[str, Any]:
    """What a table with a key for each column states of them."""
    return {} if table is None else {name: value for name, value in table if value is not None}


# --------------------------------------------------------------------- fewer rows for a long record
Rows = NDArray[np.int64]
Reduction = Literal["turning_points", "tolerance"]
# Of the largest load: what rounding may make of a distance.
_ROUNDING = 1e-12


@lru_cache(maxsize=4)  # a record of two million rows takes seconds, and is asked for by each engine
def reduced(
    rows: Table,
    average: int,
    reduction: Reduction | None,
    normal_threshold: float,
    tangential_threshold: float,
) -> Array:
    """Reduce a long record of time, P and Q to fewer rows, (m, 3), by means of neighbouring rows,
    by turning points, or by straight lines within a tolerance.

    The first and the last row always stay. Results are cached, since each solution asks for them.

    Parameters
    ----------
    rows
        the record, columns time, P and Q
    average
        how many neighbouring rows are replaced by their mean first; 1 for none
    reduction
        "turning_points": rows at which P or Q turns by more than its threshold. "tolerance":
        straight lines, each as long as it can be, that pass the other rows, in their order, at
        distances of at most the thresholds. None: all
    normal_threshold, tangential_threshold
        of P and of Q

    Examples
    --------
    >>> record = Table.of([[0, 9, 0], [1, 9, 5], [2, 9, 4.9], [3, 9, 8], [4, 9, -8]])
    >>> reduced(record, 1, "turning_points", 0.0, 0.5)[:, 2].tolist()
    [0.0, 8.0, -8.0]
    >>> reduced(record, 2, None, 0.0, 0.0)[:, 2].tolist()
    [2.5, 6.45, -8.0]
    """
    values = means(rows.values, average)
    if reduction is None:
        kept_values = values
    elif reduction == "turning_points":
        rows_of_turns = (
            turning_points(values[:, column], threshold)
            for column, threshold in ((1, normal_threshold), (2, tangential_threshold))
        )
        kept_values = values[np.unique(np.concatenate([[0, len(values) - 1], *rows_of_turns]))]
    else:
        thresholds = np.array([normal_threshold, tangential_threshold])
        kept_values = values[within(values[:, 1:], thresholds)]
    kept_values.flags.writeable = False
    return kept_values


def means(values: Array, count: int) -> Array:
    """The mean of each `count` neighbouring rows; the last of them may be of fewer."""
    if count == 1:
        return values
    starts = np.arange(0, len(values), count)
    return np.asarray(
        np.add.reduceat(values, starts, axis=0) / np.diff(starts, append=len(values))[:, None]
    )


def turning_points(values: Array, threshold: float) -> Rows:
    """Rows (m,) of a measured series `values` (n,) at which it turns round, small swings left out:
    an extreme counts once the series has left it by more than the `threshold`.

    >>> turning_points(np.array([0.0, 3.0, 2.9, 3.2, 1.0, 2.0]), threshold=0.5).tolist()
    [0, 3, 4]
    """
    steps = np.diff(values)
    moving_rows = np.flatnonzero(steps)
    # Rows of all extremes; of a plateau the first row.
    turning_rows = moving_rows[:-1][steps[moving_rows[:-1]] * steps[moving_rows[1:]] < 0] + 1
    turns: list[int] = []
    direction = 0  # of the swing that is followed: 1 up, -1 down, 0 unknown yet
    row_of_least = 0  # extremes of that swing so far
    row_of_largest = 0
    for row, value in zip(
        (*turning_rows.tolist(), len(values) - 1),
        (*values[turning_rows].tolist(), float(values[-1])),
        strict=True,
    ):
        row_of_largest = row if value > values[row_of_largest] else row_of_largest
        row_of_least = row if value < values[row_of_least] else row_of_least
        if direction >= 0 and values[row_of_largest] - value > threshold:
            turns.append(row_of_largest)
            direction = -1
            row_of_least = row
        elif direction <= 0 and value - values[row_of_least] > threshold:
            turns.append(row_of_least)
            direction = 1
            row_of_largest = row
    return np.array(turns, dtype=np.int64)


def within(path: Array, tolerance: Array) -> Rows:
    """Rows (m,) of a load path that are enough to follow it: straight lines between them pass all
    other points in their order, each within a tolerance.

    From each kept row the next one is as far away as a line allows, found by doubled, then halved
    steps. A line that is near two neighbouring points is near the straight path between them, since
    distance is convex.

    Parameters
    ----------
    path
        (n, 2) P and Q of all rows
    tolerance
        (2,) largest distance in P and in Q
    """
    slack = tolerance + _ROUNDING * np.max(np.abs(path), initial=0.0)

    def line_fits(first_row: int, last_row: int) -> bool:
        """Whether the straight line from `first_row` to `last_row` passes all rows between them in
        order, within the `slack` of each load.

        Near each row the line has an interval of positions (0 at its begin, 1 at its end). The
        intervals must allow ascending positions.
        """
        start = path[first_row]
        change = path[last_row] - path[first_row]
        points_between = path[first_row + 1 : last_row] - start
        with np.errstate(divide="ignore", invalid="ignore"):
            position_at_lower = (points_between - slack) / change
            position_at_upper = (points_between + slack) / change
        is_constant = change == 0
        if np.any(np.abs(points_between[:, is_constant]) > slack[is_constant]):
            return False
        least_position = np.max(
            np.where(is_constant, 0.0, np.minimum(position_at_lower, position_at_upper)),
            axis=1,
            initial=0.0,
        )
        largest_position = np.min(
            np.where(is_constant, 1.0, np.maximum(position_at_lower, position_at_upper)),
            axis=1,
            initial=1.0,
        )
        return bool(np.all(np.maximum.accumulate(least_position) <= largest_position))

    row_numbers = [0]
    last_number = len(path) - 1
    while row_numbers[-1] < last_number:
        first_number = row_numbers[-1]
        rows_reached = 1
        while first_number + 2 * rows_reached <= last_number and line_fits(
            first_number, first_number + 2 * rows_reached
        ):
            rows_reached *= 2
        # A line over `rows_reached` fits; one over `rows_not_reached` does not, or was not tried.
        rows_not_reached = min(2 * rows_reached, last_number - first_number + 1)
        while rows_not_reached - rows_reached > 1:
            rows_tried = (rows_reached + rows_not_reached) // 2
            if line_fits(first_number, first_number + rows_tried):
                rows_reached = rows_tried
            else:
                rows_not_reached = rows_tried
        row_numbers.append(first_number + rows_reached)
    return np.array(row_numbers, dtype=np.int64)
