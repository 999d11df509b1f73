"""Measured tables: rows of numbers from lists, or columns of text files in the units of the scene;
fewer rows for a long record.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
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
from scenes.arrays import LARGEST_NUMBER, real_numbers
from scenes.errors import InputError, RowError, shortened_repr
from scenes.frozen import Frozen
from scenes.unit_words import Kind, short_unit_in, unit_factor, unit_in

if TYPE_CHECKING:
    from scenes.text_tables import TextTable


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of finite numbers as a read-only array (n_rows, n_columns); in a scene file, a list of
    lists.

    >>> Table.of_rows([[0, 0], [1, 2]]).values.shape
    (2, 2)
    """

    values: Array

    @classmethod
    def of_rows(cls, rows: ArrayLike | Table) -> Table:
        """Table (n_rows, n_columns) of lists, of an array or of another table: rows of equally many
        finite numbers.

        Raises
        ------
        ValueError
            For rows of text or of unequal lengths; for a number that is not finite or beyond 1e100
            in size, with its row.
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

        # `RowError.refuse` raises for the first row at which the condition holds.
        rule = f"is not all finite numbers of at most {LARGEST_NUMBER:g}"
        RowError.refuse(
            ~(np.abs(values) <= LARGEST_NUMBER).all(axis=1),
            lambda row: f"{shortened_repr(values[row].tolist())} {rule}",
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
    def before_reading(cls) -> Table:
        """What stands in place of rows until a file is read; without a row."""
        return cls(np.empty((0, 0)))

    @classmethod
    def __get_pydantic_core_schema__(
        cls, _source: Any, _handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            cls.of_rows,
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
READING_KEYS = (
    "columns",
    "units",
    "thickness",
    "scale",
    "zero",
    "sign",
    "interval",
    "constant_normal_load",
)
"""Keys of a scene that say how a text file is read."""
# What some of them are, for the descriptions of keys.
DESCRIPTION_OF_COLUMNS = "headings or numbers (from 1) of columns without a usual name"
DESCRIPTION_OF_UNITS = "units of columns whose headings state none; turned into those of the scene"
DESCRIPTION_OF_SCALE = "factors of the columns, such as a calibration"
DESCRIPTION_OF_ZERO = "numbers that mean zero: taken off first, in the units of the file"
DESCRIPTION_OF_READ_AS = "how the file was read, found and assumed; written by the reader"


LIKELY_UNITS = {"length": "mm", "load": "N", "stress": "MPa", "angle": "rad"}
"""A unit of each kind, for a sentence that asks for it."""


@dataclass(frozen=True)
class ColumnUnit:
    """The unit of a column, as it was understood.

    Attributes
    ----------
    word
        the unit as it stands in the file or was stated; empty where there is none
    source
        "in its heading", "in the line of units", or "stated"
    factor
        from the numbers of the file to the unit of the scene; 1 where no unit is known
    is_per_length
        whether it is a force per length
    fault
        why the word is no unit that can be used; empty where it can
    remark
        all this for the user; empty where the unit of a time is not stated
    """

    word: str
    source: str
    factor: float
    is_per_length: bool
    fault: str
    remark: str

    @property
    def is_known(self) -> bool:
        """Whether there is a unit, and it was understood."""
        return bool(self.word) and not self.fault


def unit_of_column(
    table: TextTable,
    column_index: int,
    unit_kind: Kind,
    scene_units: str,
    stated_unit: str | None = None,
) -> ColumnUnit:
    """Unit of one column of a text table, with the factor from the file's numbers to the units of
    the scene.

    It is the unit that the user states, else that in the file's line of units, else that in the
    column's heading. Where there is none, or it is not understood, the factor is 1 and the remark
    says so.

    Parameters
    ----------
    table
        `headings` of the file's columns, and their `units` by its line of units or within the
        headings, "" where there is none
    column_index
        index of the column
    unit_kind
        kind of its unit, such as "load" or "length"
    scene_units
        units of the scene, such as "N, mm, MPa"
    stated_unit
        unit that the user states for the column, if any
    """
    heading = table.headings[column_index]

    # The unit of "P [N]" or "P / N"; and that of "Force N", a last word of up to three letters.
    _, marked_unit = unit_in(heading)
    short_unit = short_unit_in(heading, unit_kind)
    word = stated_unit or table.units[column_index] or short_unit
    source = "in its heading"
    if stated_unit:
        source = "stated"
    elif word and word not in (marked_unit, short_unit):
        source = "in the line of units"

    # Factor to the scene's unit, and whether the unit is one of force per length.
    factor = 1.0
    is_per_length = False
    fault = ""
    if not word:
        # A missing unit of time needs no remark, since it changes no result.
        remark = "" if unit_kind == "time" else "no unit stated: taken to be in that of the scene"
    else:
        try:
            factor, is_per_length = unit_factor(word, unit_kind, scene_units)
            remark = f"{word} ({source}), times {factor:.9g}"
        except ValueError as reason:
            fault = str(reason)
            remark = f"{word!r} {source} is no unit that is known: taken as it stands"
    return ColumnUnit(
        word=word,
        source=source,
        factor=factor,
        is_per_length=is_per_length,
        fault=fault,
        remark=remark,
    )


def layout_in_words(path: Path, table: TextTable) -> list[tuple[str, str]]:
    """Describe for the user how numbers were found in a text file, as (what, how): rows, separator,
    decimal sign, encoding, lines that were left out.

    The file lies at `path`. `table` holds the number of each row's line; separator, decimal sign
    and encoding in words; the number of lines above the headings; and the lines that are no rows,
    in words.
    """
    descriptions = [
        (
            "file",
            f"{path.name}: {len(table.line_numbers):,} rows from line {table.line_numbers[0]} on",
        ),
        ("columns separated by", table.separator),
        ("decimal sign", table.decimal_sign),
    ]
    if not table.encoding.startswith("UTF-8"):
        descriptions.append(("characters", table.encoding))
    if table.n_lines_above:
        descriptions.append(("lines above the headings", f"{table.n_lines_above} skipped"))
    descriptions += [("left out", words) for words in table.lines_left_out]
    return descriptions


class _ColumnReading(NamedTuple):
    """How the numbers of a column become those of the scene: (number - zero) x factor.

    Attributes
    ----------
    zero
        number of the file that means zero
    factor
        to the units of the scene
    has_known_unit
        whether there is a unit, and it was understood
    description
        all this for the user
    """

    zero: float
    factor: float
    has_known_unit: bool
    description: str


class FromFile(Frozen):
    """Part of a scene with rows of numbers, which may stand in a text `file` instead, relative to
    the scene file.

    A number of the scene is sign x scale x unit x (number of the file - zero) / thickness.
    """

    key_of_rows: ClassVar[str]
    """Name of the key that holds the rows."""
    quantities: ClassVar[dict[str, Kind]]
    """Columns of the rows in their order, and the kind of unit of each."""
    optional_column_kinds: ClassVar[dict[str, Kind]] = {}
    """Keys that are lists, an entry for each row, which may be columns of the file too, where
    `columns` names them; and the kind of unit of each.
    """

    kind: str
    file: str | None
    read_as: ReadAs | None

    @property
    def column_kinds(self) -> dict[str, Kind]:
        """The columns that a file must have, and what each is."""
        return self.quantities

    @model_validator(mode="after")
    def _read_file(self, validation: ValidationInfo) -> Self:
        """Return this part of the scene with its rows read from the text file that it names, each
        column converted into the scene's units; unchanged where the scene states the rows itself.

        Columns of bulk stress, tilt or moment become the keys of these names. The key `read_as`
        then describes, for the user, how each column was read.

        `self.key_of_rows` is the name of the key that holds the rows. `column_kinds` holds quantity
        and kind of unit of each column, `optional_column_kinds` those of bulk stress and the like.
        `validation.context` holds the folder of the scene file and the units of the scene.

        Raises
        ------
        InputError
            For a file or a unit that is not understood, and for a quantity stated twice.
        """
        # pydantic's `model_fields_set`: the keys that were given.
        if self.key_of_rows in self.model_fields_set:
            return self
        if self.file is None:
            raise PydanticCustomError(
                "key_missing", "the key {key} is missing", {"key": self.key_of_rows}
            )

        path = _folder(validation) / self.file
        stated_columns = getattr(self, "columns", None)
        # Optional columns, such as bulk stress, that the scene names; then the kind of unit of each
        # column.
        optional_names = self._optional_columns_in(stated_columns)
        unit_kinds = self.column_kinds | {
            name: self.optional_column_kinds[name] for name in optional_names
        }
        file_table = self._table_of(path, tuple(unit_kinds), stated_columns)
        # (what, how) for the key `read_as`; `_convert_columns` converts the table in place.
        descriptions = layout_in_words(path, file_table)
        descriptions += self._convert_columns(
            path, file_table, unit_kinds, _scene_units(validation)
        )

        names_stated_twice = [name for name in optional_names if getattr(self, name) is not None]
        if names_stated_twice:
            raise InputError(
                f"{self.file}: {names_stated_twice[0]} is a column of the file and stated beside"
                " it: leave one out"
            )
        values_of_keys = self._keys_of_columns(file_table.values, optional_names)
        values_of_keys["read_as"] = tuple(descriptions)
        # The model is frozen, and is still being validated here.
        for key, key_value in values_of_keys.items():
            object.__setattr__(self, key, key_value)
        self.model_fields_set.update(values_of_keys)
        return self

    def _convert_columns(
        self, path: Path, file_table: TextTable, unit_kinds: Mapping[str, Kind], scene_units: str
    ) -> list[tuple[str, str]]:
        """Convert each column of a text file's table into the scene's units, in place, and return
        what the user gets to know about it: pairs of what, and how it was read.

        After the columns come quantities that the scene states in place of columns; headings that
        were not read; and the units of the scene, if a column other than time has a unit.

        Parameters
        ----------
        path, file_table
            the file, and its rows `values` (n, columns) as they are written there
        unit_kinds
            for each column, in their order, its name and kind of unit, such as "force"
        scene_units
            units of the scene, such as "N, mm, MPa"

        Raises
        ------
        InputError
            For a unit that is not understood.
        """
        descriptions = []
        is_converted = False
        for column_index, (name, unit_kind) in enumerate(unit_kinds.items()):
            # Number that means zero, factor to the scene's units, and a description.
            column_reading = self._reading_of_column(
                path, file_table, column_index, name, unit_kind, scene_units
            )
            is_converted = is_converted or (column_reading.has_known_unit and unit_kind != "time")
            # Numbers that are not finite are refused later, with their row.
            with np.errstate(over="ignore", invalid="ignore"):
                file_table.values[:, column_index] -= column_reading.zero
                file_table.values[:, column_index] *= column_reading.factor
            descriptions.append((name, column_reading.description))
        descriptions += self._stated_quantities_in_words()
        if file_table.unread_headings:
            descriptions.append(("not read", _headings_in_words(file_table.unread_headings)))
        if is_converted:
            descriptions.append((SCENE_UNITS, scene_units))
        return descriptions

    def _keys_of_columns(self, values: Array, optional_names: Sequence[str]) -> dict[str, Any]:
        """Values of the scene's keys that the columns of a file fill in, by key: the rows
        under `self.key_of_rows`, and each optional column, such as bulk stress, under its name.

        `values` (n, columns) are in the scene's units; the optional columns come last. Quantities
        that the scene states in place of columns are put into the rows.
        """
        all_values = Table.of_rows(self._with_stated_quantities(values)).values
        n_table_columns = all_values.shape[1] - len(optional_names)
        values_of_keys: dict[str, Any] = {
            self.key_of_rows: Table.of_rows(all_values[:, :n_table_columns])
        }
        for index, name in enumerate(optional_names):
            values_of_keys[name] = tuple(all_values[:, n_table_columns + index].tolist())
        return values_of_keys

    def _table_of(
        self, path: Path, quantities: tuple[str, ...], stated_columns: Frozen | None
    ) -> TextTable:
        """The columns of some `quantities`, such as "time", of the text file at `path`.

        Each is found by its usual headings, unless the user names it. `stated_columns` is the
        scene's key `columns`: a part with the heading, or the number from 1, of those that the
        user names.

        Raises
        ------
        InputError
            For a file that cannot be read, or lacks a column.
        """
        from scenes.text_tables import text_table  # only a scene that names a file needs it

        return text_table(path, quantities, _values_by_column(stated_columns))

    def _stated_quantities_in_words(self) -> list[tuple[str, str]]:
        """Quantities that the scene states in place of a column, such as a constant P, as (name,
        description for the user).
        """
        return []

    def _with_stated_quantities(self, values: Array) -> Array:
        """Rows (n, m) of all columns, from the rows of those that the file has: the quantities that
        the scene states in place of a column are filled in.
        """
        return values

    def _reading_of_column(
        self,
        path: Path,
        table: TextTable,
        column_index: int,
        name: str,
        unit_kind: Kind,
        scene_units: str,
    ) -> _ColumnReading:
        """How the numbers of one column of a text file become those of the scene: the number that
        means zero, the factor, whether the unit is known, and a description for the user.

        Parameters
        ----------
        path
            of the file, for messages
        table
            the file's columns, headings and units
        column_index
            index of the column in the `table`
        name
            quantity that it holds, such as "P"
        unit_kind
            kind of its unit, such as "load" or "length"
        scene_units
            units of the scene, such as "N, mm, MPa"

        Raises
        ------
        InputError
            For a unit that is not understood, for forces without a thickness, and for forces
            per length with one.
        """
        # `first_clock_text`: the first cell of a column of times of day, "" where times are
        # numbers.
        heading = table.headings[column_index]
        is_time_of_day = bool(table.first_clock_text) and unit_kind == "time"
        # The unit with its factor to the scene's, and a remark for the user.
        column_unit = self._understood_unit(path, table, column_index, name, unit_kind, scene_units)
        thickness = getattr(self, "thickness", None) if unit_kind == "load" else None
        if column_unit.is_known and unit_kind == "load":
            _check_thickness(path, name, column_unit, thickness)

        # What the scene states for this column: factor, number that means zero, sign.
        stated_scale = _values_by_column(getattr(self, "scale", None)).get(name)
        zero = _values_by_column(getattr(self, "zero", None)).get(name)
        stated_sign = _values_by_column(getattr(self, "sign", None)).get(name, 1)
        # Without a line of headings, `heading` is the reader's own word, such as "column 2".
        phrases = [repr(heading) if table.heading_line_number else heading]
        if is_time_of_day:
            phrases.append(f"times of day: seconds since {table.first_clock_text}")
        elif column_unit.remark:
            phrases.append(column_unit.remark)
        if zero is not None:
            phrases.append(f"zero at {zero:.9g} of the file")
        if stated_scale is not None:
            phrases.append(f"times {stated_scale:.9g} (scale)")
        if thickness is not None:
            phrases.append(f"over the thickness {thickness:.9g}")
        if stated_sign < 0:
            phrases.append("sign turned")
        # The quotient is formed first: the order decides about the last digit.
        factor = column_unit.factor * (
            (1.0 if stated_scale is None else stated_scale) * stated_sign / (thickness or 1.0)
        )
        return _ColumnReading(
            zero=0.0 if zero is None else zero,
            factor=factor,
            has_known_unit=column_unit.is_known,
            description=", ".join(phrases),
        )

    def _understood_unit(
        self,
        path: Path,
        table: TextTable,
        column_index: int,
        name: str,
        unit_kind: Kind,
        scene_units: str,
    ) -> ColumnUnit:
        """Unit of one column of a text file, stated by the user or by the file; with the factor
        to the units of the scene.

        Parameters
        ----------
        path
            of the file, for messages
        table
            the file's columns, headings and units
        column_index
            index of the column in the `table`
        name
            quantity that it holds, such as "P"
        unit_kind
            kind of its unit, such as "load" or "length"
        scene_units
            units of the scene, such as "N, mm, MPa"

        Raises
        ------
        InputError
            For a stated unit that is not understood; for one of the file, unless it changes no
            result (times, moments) or the user states a scale.
        """
        # Units and factors that the user states, by quantity.
        stated_units = _values_by_column(getattr(self, "units", None))
        stated_scales = _values_by_column(getattr(self, "scale", None))
        # Times of day have been turned into seconds.
        if table.first_clock_text and unit_kind == "time":
            stated_units.pop(name, None)
        # The unit as a word, where it stands, its factor, and why it is not understood ("" where it
        # is).
        column_unit = unit_of_column(
            table, column_index, unit_kind, scene_units, stated_units.get(name)
        )
        if column_unit.fault and name in stated_units:
            raise InputError(f"units.{name}: {column_unit.fault}")
        # The unit of time changes no result, moments are not converted, and a stated scale turns
        # volts into loads.
        if column_unit.fault and unit_kind not in ("time", "moment") and name not in stated_scales:
            advice_for_loads = ""
            if unit_kind == "load":
                advice_for_loads = (
                    ": to loads per unit thickness, or to forces beside the key thickness"
                )
            # LIKELY_UNITS: a usual unit of each kind
            raise InputError(
                f"{path}: the heading {table.headings[column_index]!r} of {name} has"
                f" {column_unit.word!r} where a unit stands: {column_unit.fault}; state the unit of"
                f" the numbers, such as units = {{{name} = {LIKELY_UNITS[unit_kind]!r}}}, or their"
                f" factor by scale{advice_for_loads}"
            )
        return column_unit

    @classmethod
    def _optional_columns_in(cls, stated_columns: Frozen | None) -> list[str]:
        """Names of the optional columns, such as a bulk stress, that the scene's key `columns`
        states.
        """
        return [
            name for name in _values_by_column(stated_columns) if name in cls.optional_column_kinds
        ]

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Keys of this part of the scene that the user gave, with `changes` (key -> new value)
        merged in; not validated yet.

        Where the file, or how it is read, changes, the rows that were read from the old file are
        left out. Where the rows change, the file and the keys on how it is read are left out.
        `self.key_of_rows` is the name of the key that holds the rows.
        """
        keys = super().merged(changes)
        # Optional columns, such as bulk stress, that the scene names.
        optional_names = self._optional_columns_in(getattr(self, "columns", None))
        # Keys that were filled in from the file.
        keys_from_file = {"read_as"} | (set(optional_names) - changes.keys())
        rows_change = self.key_of_rows in changes
        # READING_KEYS: keys on how a file is read, such as "columns" and "units"
        reading_changes = not changes.keys().isdisjoint(("file", *READING_KEYS))
        outdated_keys: set[str] = set()
        if rows_change and "file" not in changes:
            outdated_keys = {"file", *READING_KEYS} | keys_from_file
        elif not rows_change and keys.get("file") is not None and reading_changes:
            outdated_keys = {self.key_of_rows} | keys_from_file
        for key in outdated_keys:
            keys.pop(key, None)
        return keys

    @abc.abstractmethod
    def check_rows(self) -> None:
        """Refuse rows that are no valid measurement: RowError with the first row at fault."""

    @model_validator(mode="after")
    def _require_valid_rows(self, validation: ValidationInfo) -> Self:
        """Return this part of the scene; refuse (ValueError) rows that are no valid measurement,
        with the line of the file that they come from. Keys on how a file is read are refused too,
        where no file is named.

        `self.key_of_rows` is the name of the key that holds the rows. `file` is the name of the
        text file, None where the scene states the rows itself. `validation` holds the folder of the
        scene file.
        """
        try:
            self.check_rows()
        except RowError as fault:
            path = _folder(validation) / (self.file or "")
            place = f"{self.key_of_rows}, row {fault.row + 1}"
            if self.file is not None and path.is_file():  # where the rows came from
                from scenes.text_tables import text_table

                stated_columns = _values_by_column(getattr(self, "columns", None))
                file_table = text_table(path, tuple(self.column_kinds), stated_columns)
                place = f"{path}, line {file_table.line_numbers[fault.row]}"
            raise ValueError(f"{place}: {fault.rule}") from fault
        # READING_KEYS: keys on how a file is read, such as "columns" and "units"
        unused_keys = [key for key in READING_KEYS if getattr(self, key, None) is not None]
        if self.file is None and unused_keys:
            raise ValueError(
                f"{unused_keys[0]} says how a file is read, and `{self.key_of_rows}` stand in the"
                " units of the scene: leave it out"
            )
        return self


def _check_thickness(
    path: Path, name: str, column_unit: ColumnUnit, thickness: float | None
) -> None:
    """Refuse a column of forces where the scene states no thickness to divide them by, and one of
    forces per length where it does (InputError).

    Parameters
    ----------
    path
        of the file, for the message
    name
        quantity of the column, such as "P"
    column_unit
        `is_per_length`: whether it is a force per length; the word in the file, and where it stands
    thickness
        of the contact out of the plane [length], or None
    """
    if column_unit.is_per_length != (thickness is not None):
        return
    fault_text = (
        "a force, and loads are per unit thickness: state the key thickness, the length of"
        " the contact out of the plane, by which it is divided"
    )
    if column_unit.is_per_length:
        fault_text = "per length already: leave out the key thickness"
    raise InputError(
        f"{path}: {name} is in {column_unit.word} ({column_unit.source}), {fault_text}"
    )


def _scene_units(validation: ValidationInfo) -> str:
    """Units of the scene that is being read, such as "N, mm, MPa", which they are where it states
    none. `validation.context` holds them under "units".
    """
    units = (validation.context or {}).get("units")
    # _DEFAULT_UNITS: "N, mm, MPa"
    return units if isinstance(units, str) else _DEFAULT_UNITS


def _folder(validation: ValidationInfo) -> Path:
    """Where the scene file lies."""
    return Path((validation.context or {}).get("folder", "."))


# Headings of unused columns that a sentence lists.
_MOST_HEADINGS = 12
# Units of the scene where it states none.
_DEFAULT_UNITS = "N, mm, MPa"
SCENE_UNITS = "units of the scene"
"""Key of `read_as`: into which units the columns of a file were turned; left out where none was."""


def _headings_in_words(headings: Sequence[str]) -> str:
    """Headings for a sentence: the first twelve, and the number of the others."""
    first_headings = ", ".join(map(repr, headings[:_MOST_HEADINGS]))
    n_unlisted = len(headings) - _MOST_HEADINGS
    return f"{first_headings} and {n_unlisted} more" if n_unlisted > 0 else first_headings


def _values_by_column(table: Frozen | None) -> dict[str, Any]:
    """Column name -> what a part of the scene with a key for each column states of it."""
    return {} if table is None else {name: value for name, value in table if value is not None}


# --------------------------------------------------------------------- fewer rows for a long record
Rows = NDArray[np.int64]
Reduction = Literal["turning_points", "tolerance"]
# Round-off of a distance in the P-Q plane, over the largest load.
_ROUND_OFF_SHARE = 1e-12


@lru_cache(maxsize=4)  # a record of two million rows takes seconds, and is asked for by each engine
def reduced_record(
    rows: Table,
    average: int,
    reduction: Reduction | None,
    normal_threshold: float,
    tangential_threshold: float,
) -> Array:
    """Rows (m, 3) of time, P and Q that stand for a long record: means of neighbouring rows, of
    which the turning points or the ends of straight lines within a tolerance are taken.

    The first and the last row (or mean) always stay. Arrays are read-only and cached, since each
    solution needs them.

    Parameters
    ----------
    rows
        the record (n, 3), columns time, P and Q
    average
        how many neighbouring rows are replaced by their mean first; 1 for none
    reduction
        "turning_points": rows at which P or Q reverses after a swing above its threshold.
        "tolerance": ends of straight lines, each as long as it can be. They pass the other rows, in
        their order, at distances of at most the thresholds. None: all rows
    normal_threshold, tangential_threshold
        of P and of Q [force per unit thickness]

    Examples
    --------
    >>> record = Table.of_rows([[0, 9, 0], [1, 9, 5], [2, 9, 4.9], [3, 9, 8], [4, 9, -8]])
    >>> reduced_record(record, 1, "turning_points", 0.0, 0.5)[:, 2].tolist()
    [0.0, 8.0, -8.0]
    >>> reduced_record(record, 2, None, 0.0, 0.0)[:, 2].tolist()
    [2.5, 6.45, -8.0]
    """
    # Means (m, 3) of neighbouring rows.
    values = means_of_neighbours(rows.values, average)
    if reduction is None:
        kept_values = values
    elif reduction == "turning_points":
        rows_of_ends = [0, len(values) - 1]
        turning_rows_of_p = rows_of_turning_points(values[:, 1], normal_threshold)
        turning_rows_of_q = rows_of_turning_points(values[:, 2], tangential_threshold)
        kept_values = values[
            np.unique(np.concatenate([rows_of_ends, turning_rows_of_p, turning_rows_of_q]))
        ]
    else:
        thresholds = np.array([normal_threshold, tangential_threshold])
        kept_values = values[rows_within_tolerance(values[:, 1:], thresholds)]
    kept_values.flags.writeable = False
    return kept_values


def means_of_neighbours(values: Array, n_rows_per_mean: int) -> Array:
    """Mean of each `n_rows_per_mean` neighbouring rows of `values` (n, m), one row each; the last
    mean may be of fewer rows.
    """
    if n_rows_per_mean == 1:
        return values
    first_rows_of_means = np.arange(0, len(values), n_rows_per_mean)
    return np.asarray(
        np.add.reduceat(values, first_rows_of_means, axis=0)
        / np.diff(first_rows_of_means, append=len(values))[:, None]
    )


def rows_of_turning_points(values: Array, threshold: float) -> Rows:
    """Row numbers (m,) of the turning points of a measured series `values` (n,), small swings left
    out: an extreme counts once the series has left it by more than the `threshold`. The first
    value may be a turning point, the last is not.

    >>> rows_of_turning_points(np.array([0.0, 3.0, 2.9, 3.2, 1.0, 2.0]), threshold=0.5).tolist()
    [0, 3, 4]
    """
    changes = np.diff(values)
    # Rows from which the value changes.
    moving_rows = np.flatnonzero(changes)
    # Rows of all extremes, large or small; of a plateau the first row.
    extreme_rows = moving_rows[:-1][changes[moving_rows[:-1]] * changes[moving_rows[1:]] < 0] + 1

    # An extreme counts once the series has moved away from it by more than the threshold.
    turning_rows: list[int] = []
    swing_direction = 0  # of the swing that is followed: 1 up, -1 down, 0 unknown
    row_of_least_value = 0  # of the least and the largest value in that swing so far
    row_of_largest_value = 0
    for row, value in zip(
        (*extreme_rows.tolist(), len(values) - 1),
        (*values[extreme_rows].tolist(), float(values[-1])),
        strict=True,
    ):
        if value > values[row_of_largest_value]:
            row_of_largest_value = row
        if value < values[row_of_least_value]:
            row_of_least_value = row
        if swing_direction >= 0 and values[row_of_largest_value] - value > threshold:
            turning_rows.append(row_of_largest_value)
            swing_direction = -1
            row_of_least_value = row
        elif swing_direction <= 0 and value - values[row_of_least_value] > threshold:
            turning_rows.append(row_of_least_value)
            swing_direction = 1
            row_of_largest_value = row
    return np.array(turning_rows, dtype=np.int64)


def _line_fits(loads: Array, first_row: int, last_row: int, tolerance_and_roundoff: Array) -> bool:
    """Whether the straight line in the P-Q plane between two rows of a load path passes all rows
    between them in order, within a tolerance of each load.

    Positions on the line go from 0 at its begin to 1 at its end. Near each row between, those
    within the tolerance are an interval. The line fits if ascending positions can be chosen, one in
    each interval.

    Parameters
    ----------
    loads
        (n, 2) P and Q of all rows [force per unit thickness]
    first_row, last_row
        row numbers of begin and end of the line
    tolerance_and_roundoff
        (2,) largest distance in P and in Q
    """
    # Change of P and Q along the line, and the loads of rows between, from its begin.
    change_along_line = loads[last_row] - loads[first_row]
    loads_from_first_row = loads[first_row + 1 : last_row] - loads[first_row]
    with np.errstate(divide="ignore", invalid="ignore"):
        # Positions on the line at which a load is just within the tolerance of a row.
        position_at_lower_bound = (
            loads_from_first_row - tolerance_and_roundoff
        ) / change_along_line
        position_at_upper_bound = (
            loads_from_first_row + tolerance_and_roundoff
        ) / change_along_line
    # A load that does not change along the line allows all positions or none.
    is_constant = change_along_line == 0
    if np.any(np.abs(loads_from_first_row[:, is_constant]) > tolerance_and_roundoff[is_constant]):
        return False
    least_position = np.max(
        np.where(is_constant, 0.0, np.minimum(position_at_lower_bound, position_at_upper_bound)),
        axis=1,
        initial=0.0,
    )
    largest_position = np.min(
        np.where(is_constant, 1.0, np.maximum(position_at_lower_bound, position_at_upper_bound)),
        axis=1,
        initial=1.0,
    )
    return bool(np.all(np.maximum.accumulate(least_position) <= largest_position))


def rows_within_tolerance(loads: Array, tolerance: Array) -> Rows:
    """Row numbers (m,) of a load path that are enough to follow it: straight lines in the P-Q plane
    between these rows pass all others in their order, within a tolerance of each load.

    The next kept row is as far from the last one as a line within the tolerance allows. The number
    of rows between is doubled until no such line fits, then found by bisection. A line that is near
    two neighbouring points is near the straight path between them, since distance is convex.

    Parameters
    ----------
    loads
        (n, 2) P and Q of all rows [force per unit thickness]
    tolerance
        (2,) largest distance in P and in Q [force per unit thickness]
    """
    # Round-off: 1e-12 of the largest load.
    tolerance_and_roundoff = tolerance + _ROUND_OFF_SHARE * np.max(np.abs(loads), initial=0.0)

    # From each kept row, double the number of rows that a line spans until it fits no more.
    kept_rows = [0]
    last_row = len(loads) - 1
    while kept_rows[-1] < last_row:
        first_row = kept_rows[-1]
        n_rows_that_fit = 1
        while first_row + 2 * n_rows_that_fit <= last_row and _line_fits(
            loads, first_row, first_row + 2 * n_rows_that_fit, tolerance_and_roundoff
        ):
            n_rows_that_fit *= 2
        # A line over n_rows_too_many does not fit, or goes beyond the last row: bisection.
        n_rows_too_many = min(2 * n_rows_that_fit, last_row - first_row + 1)
        while n_rows_too_many - n_rows_that_fit > 1:
            n_rows_tried = (n_rows_that_fit + n_rows_too_many) // 2
            if _line_fits(loads, first_row, first_row + n_rows_tried, tolerance_and_roundoff):
                n_rows_that_fit = n_rows_tried
            else:
                n_rows_too_many = n_rows_tried
        kept_rows.append(first_row + n_rows_that_fit)
    return np.array(kept_rows, dtype=np.int64)
