"""Columns of numbers from CSV files or lists: read once at the door, with errors that name file, line and rule."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo, model_validator
from pydantic_core import CoreSchema, core_schema

from scenes.bounded import TEXT, check_size, shown
from scenes.frozen import Frozen

Array = NDArray[np.float64]

# Rows of a table, characters of a row: what is longer would take gigabytes on its way through the engines.
MOST_ROWS, _LONGEST = 2_000_000, 100_000
# UTF-8, and a mark of byte order, which spreadsheets put at the front, is no part of the first name or number.
_ENCODING = "utf-8-sig"
_CURE = "; commas between the columns, points in the numbers"
# Of a number: the square of a larger one, in whatever units, would be none.
LARGEST = 1e100


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of finite numbers as a read-only array (n_rows, n_columns); in a scene file, a list of lists.

    >>> Table.of([[0, 0], [1, 2]]).values.shape
    (2, 2)
    """

    values: Array

    @classmethod
    def of(cls, rows: ArrayLike | Table) -> Table:
        """A table from anything that makes a rectangle of finite numbers; ValueError with the row if it does not."""
        try:
            values = np.asarray(rows.values, dtype=float) if isinstance(rows, Table) else np.array(rows, dtype=float)
        except (TypeError, ValueError, OverflowError):  # the last: an integer of more digits than a number can have
            values = np.empty(0)
        if values.ndim != 2 or not len(values):
            raise ValueError("rows of equally many numbers are needed")
        bad = np.flatnonzero(~(np.abs(values) <= LARGEST).all(axis=1))
        if len(bad):
            raise ValueError(f"row {bad[0] + 1}: {shown(values[bad[0]].tolist())} is not all finite numbers of at most {LARGEST:g}")
        values.flags.writeable = False
        return cls(values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        return hash((self.values.shape, self.values.tobytes()))

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        return f"Table({len(self.values)} rows of {self.values.shape[1]})"

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: Any, _handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            cls.of, serialization=core_schema.plain_serializer_function_ser_schema(lambda table: table.values.tolist())
        )

    @classmethod
    def __get_pydantic_json_schema__(cls, _schema: CoreSchema, _handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}


class RowError(ValueError):
    """A fault in one row of a table: `row` counts the rows of numbers from 0."""

    def __init__(self, row: int, rule: str) -> None:
        self.row, self.rule = row, rule
        super().__init__(f"row {row + 1}: {rule}")


def _rows_may_stand_in_a_file(schema: dict[str, Any], model: type[FromFile]) -> None:
    schema["required"].remove(model.table)


class FromFile(Frozen):
    """Keys of which one, `table`, is rows of numbers that may stand in a CSV `file` instead, relative to the scene file."""

    model_config = ConfigDict(json_schema_extra=_rows_may_stand_in_a_file)

    table: ClassVar[str]
    columns: ClassVar[tuple[str, ...]]

    kind: str
    file: str | None

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("file"), str) or data.get(cls.table) is not None:
            return data
        return data | {cls.table: read_table(_folder(info) / data["file"], cls.columns)}

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """As for every table; rows of one file are not those of another, nor is a file the source of other rows."""
        data = super().merged(changes)
        if changes.get("file") is not None and self.table not in changes:
            del data[self.table]
        if self.table in changes and "file" not in changes:
            data["file"] = None
        return data

    def place_of(self, fault: RowError, info: ValidationInfo) -> str:
        """Where the user finds a bad row: line of the `file` that the table was read from, else row of the table."""
        path = _folder(info) / (self.file or "")
        if self.file is not None and path.is_file():
            return f"{path}, line {_line_of(path, fault.row, self.columns)}"
        return f"{self.table}, row {fault.row + 1}"


def _folder(info: ValidationInfo) -> Path:
    """Where the scene file lies."""
    return Path((info.context or {}).get("folder", "."))


def read_table(path: Path, names: tuple[str, ...]) -> Table:
    """The columns `names` of a CSV file; a first line of these names may be there, lines that start with # are skipped.

    Raises
    ------
    ValueError
        One sentence that names file, line and rule.
    """
    try:
        check_size(path, "the table", TEXT, "thin it out")
        _check_rows(path)
        with path.open(encoding=_ENCODING) as file:
            head = list(itertools.islice(_numbered(file), 1))
    except (OSError, UnicodeDecodeError) as reason:
        why = reason.strerror if isinstance(reason, OSError) else "it is not UTF-8 text"
        raise ValueError(f"{path}: the file can't be read: {why}") from reason
    if not head:
        raise ValueError(f"{path}: the file is empty; {len(names)} columns {', '.join(names)} are needed")
    skip = _header_lines(path, head[0], names)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # numpy's remark on a file without rows: refused below
            values = np.loadtxt(path, delimiter=",", comments="#", skiprows=skip, ndmin=2, encoding=_ENCODING)
    except ValueError as reason:
        raise ValueError(_first_fault(path, skip, names)) from reason
    if values.shape[0] == 0 or values.shape[1] != len(names):
        raise ValueError(_first_fault(path, skip, names))
    try:
        return Table.of(values)
    except ValueError as reason:
        raise ValueError(_first_fault(path, skip, names)) from reason


def _line_of(path: Path, row: int, names: tuple[str, ...]) -> int:
    """The line of the file, counted from 1, on which the row of numbers `row`, counted from 0, stands."""
    with path.open(encoding=_ENCODING) as file:
        lines = _numbered(file)
        first = next(lines)
        skip = _header_lines(path, first, names)
        every = itertools.chain([] if skip else [first], lines)
        return next(itertools.islice(every, row, None))[0]


def _check_rows(path: Path) -> None:
    """ValueError for more lines than are read, or one too long to be a row; counted before anything of it is kept."""
    number = 0
    with path.open("rb") as file:
        while line := file.readline(_LONGEST + 1):
            number += 1
            if len(line) > _LONGEST:
                raise ValueError(f"{path}, line {number}: more than {_LONGEST:,} characters are no row of a table")
            if number > MOST_ROWS:
                raise ValueError(f"{path}: the table has more than {MOST_ROWS:,} lines, the most that are read; thin it out")


def _numbered(lines: Iterator[str] | Any) -> Iterator[tuple[int, str]]:
    """(line number, text) of the lines that hold anything."""
    for number, line in enumerate(lines, start=1):
        text = line.split("#", 1)[0].strip()
        if text:
            yield number, text


def _header_lines(path: Path, first: tuple[int, str], names: tuple[str, ...]) -> int:
    number, text = first
    cells = [cell.strip().strip('"') for cell in text.split(",")]
    if any(_is_number(cell) for cell in cells):
        return 0
    if [cell.lower() for cell in cells] != [name.lower() for name in names]:
        cure = _CURE if ";" in text or "\t" in text else ""
        raise ValueError(f"{path}, line {number}: the columns are {', '.join(names)}, not {shown(text)}{cure}")
    return number


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _first_fault(path: Path, skip: int, names: tuple[str, ...]) -> str:
    """What is wrong with the first bad line, found by going through them one by one."""
    with path.open(encoding=_ENCODING) as file:
        for number, text in _numbered(file):
            if number <= skip:
                continue
            cells = text.split(",")
            if len(cells) != len(names):
                cure = _CURE if len(cells) == 2 * len(names) else ""  # as many as decimal commas would make
                return f"{path}, line {number}: {len(names)} numbers ({', '.join(names)}) are needed, not {shown(text)}{cure}"
            for name, cell in zip(names, cells, strict=True):
                if not _is_number(cell) or not abs(float(cell)) <= LARGEST:
                    return f"{path}, line {number}: {name} = {shown(cell.strip())} is not a finite number of at most {LARGEST:g}"
    return f"{path}: no row of numbers; {len(names)} columns {', '.join(names)} are needed"
