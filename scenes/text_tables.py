"""Text tables that other programs write, to columns of numbers: separator, decimal sign, headings,
units, the line of each fault.

A table is a line of headings, perhaps a line of units and other lines without numbers, then rows of
numbers, perhaps lines of text behind them. The first lines show
which separator it has; the rows are streamed, so that two million of them take no more memory than
their numbers.
"""

from __future__ import annotations

import contextlib
import csv
import re
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice, pairwise
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from scenes.array_types import Array
from scenes.arrays import LARGEST
from scenes.clock_times import WORDS, ClockColumn, is_clock_time
from scenes.column_names import ALIASES, aliases_of, plain
from scenes.errors import InputError, shown
from scenes.files import TEXT, check_size
from scenes.unit_words import is_unit, name_without_unit, unit_in

# Rows of a table, characters of a row: what is longer would take gigabytes on its way through the
# engines. A row of somebody else's table may hold all the frames of a point.
MOST_ROWS = 2_000_000
_LONGEST_LINE = 100_000
_LONGEST_LINE_OF_ALL = 10_000_000
# What a file may be written in; a mark of byte order, which spreadsheets put at the front, is no
# part of the first name or number.
_ENCODINGS = {
    "utf-8-sig": "UTF-8",
    "cp1252": "Windows-1252, since it is not UTF-8",
    "cp932": "Shift-JIS, since it is neither UTF-8 nor Windows-1252",
    "latin-1": "Latin-1, since no other set of characters fits",
    "utf-16": "UTF-16",
    "utf-16-le": "UTF-16, without its mark of byte order",
    "utf-16-be": "UTF-16, without its mark of byte order",
}
_MARKS_OF_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
# Of every second byte: European text in UTF-16 has more zeros than that in one half, no other has.
_ZEROS_OF_UTF_16 = 0.8
# What an instrument writes where a unit stands, which is none of a load or a length.
_RAW_UNITS = ("v", "mv", "volt", "volts", "bit", "counts", "div")
# A line that has units, in the languages of `column_names`.
_WORDS_FOR_UNITS = re.compile(r"unit|einheit|unidad")
# Lines that are looked at before the table is read, bytes that show what it is written in.
_MOST_LINES_LOOKED_AT = 200
_MOST_BYTES_LOOKED_AT = 50_000
# How a file begins that is JSON, XML or HTML: no heading does.
_MARKUP_START = re.compile(r"\s*(?:\{|\[\s*(?:[\[{\"\d-]|$)|<[?!\w])")
_REMARK_MARKS = ("#", "**", "%", "//")
SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma", None: "blanks"}
# A number whose digits stand in groups of three: 1,234.5 or 1.234,5 or 1 234 or 1'234.
_GROUPED_DIGITS = re.compile(r"[-+]?\d{1,3}([.,'’ \u00a0\u202f]\d{3})+([.,]\d*)?$")


class MissingColumnError(InputError):
    """A table has no heading of these `columns` among its `headings`."""

    def __init__(self, columns: Sequence[str], headings: Sequence[str], sentence: str) -> None:
        self.columns = tuple(columns)
        self.headings = tuple(headings)
        super().__init__(sentence)


@dataclass(frozen=True, eq=False)
class TextTable:
    """The numbers of a text file, and how they were found in it.

    Attributes
    ----------
    names
        of the columns: those asked for, else the headings
    values
        (n_rows, n_columns)
    lines
        (n_rows,) the line of each row
    headings
        of these columns in the file; "column 2" where it has no line of headings
    units
        of these columns in the file, empty where none stands there
    separator, decimal, encoding
        words
    head
        number of the line of headings, 0 where there is none
    skipped
        number of lines above it that are no remarks
    unused
        headings of the columns that were not asked for
    left_out
        lines that are no rows, in words: between headings and rows, behind the rows, headings
        that are repeated
    clock_start
        the first cell of a column of times of day, empty where times are numbers
    """

    names: tuple[str, ...]
    values: Array
    lines: NDArray[np.int64]
    headings: tuple[str, ...]
    units: tuple[str, ...]
    separator: str
    decimal: str
    encoding: str
    head: int
    skipped: int
    unused: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    clock_start: str = ""

    def column(self, name: str) -> Array:
        """The first column of that name, (n_rows,)."""
        return np.asarray(self.values[:, self.names.index(name)])


@dataclass(frozen=True)
class _Layout:
    """Where the table stands in its file: `first` is the line of its first row, `used` are the
    columns that are read, `between` the lines between headings and rows that hold neither units
    nor numbers; `clock` is which of the columns holds times.
    """

    separator: str | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    used: tuple[int, ...]
    head: int
    first: int
    skipped: int
    between: tuple[int, ...] = ()
    clock: int | None = None


Line = tuple[int, str]
# Index of a row among some lines, its separator, and its cells.
FirstRow = tuple[int, str | None, list[str]]


@dataclass(frozen=True)
class TableKind:
    """What a kind of text table is to the user, and which headings it has.

    Attributes
    ----------
    role, cure
        what the file is to the user, and what to do about one that is too large
    is_known
        whether a heading is one of those expected, where no columns are asked for
    example, keys_by_number
        headings of this kind of table, and the keys that take columns by number instead; both
        for the sentence of a refusal
    numbered
        whether rows without a line of headings are read where no columns are asked for, as
        "column 1" and so on
    """

    role: str = "the table"
    cure: str = "thin it out"
    is_known: Callable[[str], bool] = lambda _heading: False
    example: str = "time,x,pressure,shear"
    keys_by_number: str = ""
    numbered: bool = False


@dataclass(frozen=True)
class _Request:
    """Which columns of which file are wanted; the attributes are the parameters of `text_table`."""

    path: Path
    columns: tuple[str, ...]
    stated: Mapping[str, str | int]
    kind: TableKind

    @property
    def by_number(self) -> bool:
        """Whether all columns are stated by number."""
        stated_columns = [self.stated.get(name) for name in self.columns]
        return bool(self.columns) and all(isinstance(place, int) for place in stated_columns)


def text_table(
    path: Path,
    columns: tuple[str, ...] = (),
    stated: Mapping[str, str | int] | None = None,
    kind: TableKind = TableKind(),
) -> TextTable:
    """Read columns of numbers from a text file that some program has written, whatever its
    separator, decimal sign, encoding and headings.

    Lines that start with #, **, % or // are remarks.

    Parameters
    ----------
    path
        of the file
    columns
        quantities that are asked for, each found by the headings that are known for it. The line
        of headings may be left out where the file has these columns alone, in this order. A # in a
        row then begins a remark. Empty: every column
    stated
        heading, or number from 1 on, of columns that the user named
    kind
        what the table is to the user, for messages, and which headings are known where no columns
        are asked for

    Raises
    ------
    InputError
        One sentence that names file, line, column, value and rule.
    """
    request = _Request(path, columns, stated or {}, kind)
    for name, heading_or_number in request.stated.items():
        if isinstance(heading_or_number, int) and heading_or_number < 1:
            raise InputError(
                f"{path}: columns = {{{name} = {heading_or_number}}} is refused: columns are"
                " numbered from 1 on"
            )
    longest_line = _LONGEST_LINE if columns else _LONGEST_LINE_OF_ALL
    try:
        check_size(path, kind.role, TEXT, kind.cure)
        with path.open("rb") as binary:
            first_bytes = binary.read(_MOST_BYTES_LOOKED_AT)
        encodings = _encodings_of(first_bytes)
        is_utf_16 = encodings[0].startswith("utf-16")
        for encoding in encodings:
            with contextlib.suppress(UnicodeError), path.open(encoding=encoding) as stream:
                read_lines = partial(_lines, path, stream, longest_line)
                return _table_in_lines(request, read_lines, _ENCODINGS[encoding])
    except OSError as reason:
        raise InputError(f"{path}: the file can't be read: {reason.strerror}") from reason
    raise InputError(
        f"{path}: the file can't be read: it is not {'UTF-16' if is_utf_16 else 'UTF-8'} text"
    )


def _table_in_lines(
    request: _Request, read_lines: Callable[[], Iterator[Line]], encoding_in_words: str
) -> TextTable:
    """Find the layout of a text table in the first lines of its file, then read all its rows.

    Parameters
    ----------
    request
        file, columns and kind of the table
    read_lines
        yields the lines of the file from the first one on at each call
    encoding_in_words
        what the file is written in, for the user

    Raises
    ------
    InputError
        One sentence on the first line that does not fit.
    """
    first_lines = list(islice(read_lines(), _MOST_LINES_LOOKED_AT))
    layout = None
    if request.kind.numbered and not request.columns:
        layout = _rows_alone(first_lines)
    if layout is None:
        layout = _layout(request, first_lines)
    has_decimal_comma = layout.separator != "," and _has_decimal_comma(read_lines(), layout)
    rows = _numbers(request, read_lines, layout, has_decimal_comma)
    headings = tuple(layout.names[k] for k in layout.used)
    if not layout.head:
        headings = tuple(f"column {k + 1}" for k in layout.used)
    return TextTable(
        names=request.columns or headings,
        values=rows.values,
        lines=rows.lines,
        headings=headings,
        units=tuple(layout.units[k] for k in layout.used),
        separator=SEPARATORS[layout.separator],
        decimal="comma" if has_decimal_comma else "point",
        encoding=encoding_in_words,
        head=layout.head,
        skipped=layout.skipped,
        unused=_unused(layout),
        left_out=(*_between_in_words(layout), *rows.left_out),
        clock_start=rows.clock_start,
    )


def _encodings_of(start: bytes) -> list[str]:
    """Encodings that a text file may be written in, by its first bytes, the likeliest first:
    UTF-16 has a mark at its start, or a zero in most of every second byte.

    >>> _encodings_of("Zeit;P".encode("utf-16-le")), _encodings_of(b"time,P")
    (['utf-16-le'], ['utf-8-sig', 'cp1252', 'cp932', 'latin-1'])
    """
    if start.startswith(_MARKS_OF_UTF_16):
        return ["utf-16"]
    if b"\0" not in start:
        return ["utf-8-sig", "cp1252", "cp932", "latin-1"]
    pairs = max(len(start) // 2, 1)
    if start[1::2].count(0) > _ZEROS_OF_UTF_16 * pairs:
        return ["utf-16-le"]
    if start[0::2].count(0) > _ZEROS_OF_UTF_16 * pairs:
        return ["utf-16-be"]
    return ["utf-8-sig"]


def _unused(layout: _Layout) -> tuple[str, ...]:
    """Headings of the columns that are not read."""
    if not layout.head:
        return ()
    return tuple(
        name for number, name in enumerate(layout.names) if name and number not in layout.used
    )


def _between_in_words(layout: _Layout) -> list[str]:
    """The lines between headings and rows that are left out."""
    if not layout.between:
        return []
    lines = ", ".join(map(str, layout.between[:5]))
    return [f"line {lines}, between the headings and the rows: no numbers"]


def _lines(path: Path, stream: TextIO, longest_line: int) -> Iterator[Line]:
    """Yield number and text of every line of an open file that is not empty, from the first line
    on; InputError for a line longer than `longest_line` characters.
    """
    stream.seek(0)
    for number, line in enumerate(iter(partial(stream.readline, longest_line + 1), ""), 1):
        if len(line) > longest_line:
            raise InputError(
                f"{path}, line {number}: more than {longest_line:,} characters are no row of a"
                " table"
            )
        if line.strip():
            yield number, line.strip(" \r\n")


def _cells(text: str, separator: str | None) -> list[str]:
    """The cells of a line; empty ones at its end are none. A separator within quotes is none."""
    texts = text.split(separator)
    if '"' in text and separator is not None:
        with contextlib.suppress(csv.Error, StopIteration):
            texts = next(csv.reader([text], delimiter=separator, skipinitialspace=True))
    cells = [cell.strip().strip('"').strip() for cell in texts]
    while len(cells) > 1 and not cells[-1]:
        del cells[-1]
    return cells


def _number(text: str, comma: bool) -> float | None:
    """None where it is no number as this file writes them."""
    if "_" in text or (comma and "." in text):
        return None
    with_point = text.replace(",", ".") if comma else text
    try:
        return float(with_point)
    except ValueError:
        return None


def _numeric(text: str, separator: str | None) -> bool:
    """Whether every cell is a number, with or without marks between thousands, or a time of day."""
    return all(
        _is_number_or_time(cell, separator) or _GROUPED_DIGITS.match(cell)
        for cell in _cells(text, separator)
    )


def _headings(text: str, separator: str | None) -> list[list[str]]:
    """The ways to cut a line of headings: where blanks separate, a heading may hold single ones."""
    ways = [_cells(text, separator)]
    return (
        ways
        if separator is not None
        else [[cell.strip('"') for cell in re.split(r"\s{2,}|\t", text)], *ways]
    )


def _rows_alone(lines: list[Line]) -> _Layout | None:
    """Layout of a text table without headings that begins with a row of two numbers or more, its
    columns named "column 1" and so on; None where the first line is no such row.
    """
    lines_without_remarks = [
        (number, text) for number, text in lines if not text.startswith(_REMARK_MARKS)
    ]
    if not lines_without_remarks:
        return None
    number, text = lines_without_remarks[0]
    for mark in SEPARATORS:
        cells = _cells(text, mark)
        if len(cells) > 1 and _numeric(text, mark):
            names = tuple(f"column {k + 1}" for k in range(len(cells)))
            return _Layout(mark, names, ("",) * len(cells), tuple(range(len(cells))), 0, number, 0)
    return None


def _layout(request: _Request, lines: list[Line]) -> _Layout:
    """Find where headings, units and rows of a text table stand, and its separator, from the first
    `lines` of its file.

    A line is taken for the headings where it has those that are asked for. Without such, a line
    with two known headings is looked for first, then the first line of two words or more. Where no
    line has headings, the rows may stand alone.

    Raises
    ------
    InputError
        For a file that has no such table.
    """
    path = request.path
    columns = request.columns
    lines_without_remarks = [line for line in lines if not line[1].startswith(_REMARK_MARKS)]
    needed_text = "a line of names and rows of numbers"
    if columns:
        needed_text = f"{len(columns)} columns {', '.join(columns)}"
    if not lines_without_remarks:
        raise InputError(f"{path}: the file is empty; {needed_text} are needed")
    if _MARKUP_START.match(lines_without_remarks[0][1]):
        raise InputError(
            f"{path}: this is JSON, XML or HTML and no table: write {needed_text}, separated"
            " by commas"
        )
    fewest_known_headings = (0,) if columns else (2, 0)
    for fewest_known in fewest_known_headings:
        layouts_with_uneven_rows: list[_Layout] = []
        for index in range(len(lines)):
            if _is_row(lines[index][1], max(len(columns), 1)):
                break
            for layout, has_even_rows in _layouts_below(request, lines, index, fewest_known):
                if has_even_rows:
                    return layout
                layouts_with_uneven_rows.append(layout)
        # Rows without a cell for each heading are at fault, if no other line fits. A line with
        # another separator than the rows does not have their headings.
        _, mark_of_rows, cells_of_row = _first_row(lines_without_remarks, max(len(columns), 2))
        for layout in layouts_with_uneven_rows:
            if not cells_of_row or layout.separator == mark_of_rows:
                return layout
    return _plain_layout(request, lines_without_remarks)


def _is_row(text: str, fewest_cells: int) -> bool:
    """Whether a line is a row of numbers by any separator, and no remark."""
    return not text.startswith(_REMARK_MARKS) and any(
        len(_cells(text, mark)) >= fewest_cells and _numeric(text, mark) for mark in SEPARATORS
    )


def _layouts_below(
    request: _Request, lines: list[Line], index: int, fewest_known: int
) -> Iterator[tuple[_Layout, bool]]:
    """Possible layouts of a text table whose headings stand in `lines[index]`, one for each way to
    cut that line; each with whether the first row has a cell for each heading.

    Parameters
    ----------
    request
        the columns that are asked for, if any
    lines
        first lines of the file, with their numbers
    index
        of the line that may have the headings
    fewest_known
        how many headings must be known names, where no columns are asked for
    """
    line_number, text = lines[index]
    is_remark = text.startswith(_REMARK_MARKS)
    heading_text = text.lstrip("#*%/ ") if is_remark else text
    for mark in SEPARATORS:
        for names in _headings(heading_text, mark):
            if request.columns:
                used_columns = _used(request, line_number, names)
            else:
                used_columns = tuple(range(len(names)))
                known_count = sum(map(request.kind.is_known, names))
                if is_remark or len(names) < 2 or known_count < fewest_known:
                    continue
            if used_columns is None or request.by_number:
                continue
            may_skip_lines = bool(request.columns) or fewest_known > 0
            layout, first_row = _layout_with_headings(
                request, lines, index, mark, _NamedColumns(names, used_columns), may_skip_lines
            )
            has_even_rows = first_row is None or (
                _fits(first_row, mark, used_columns, len(names))
                and _has_number(first_row, mark, used_columns)
            )
            # A remark has headings only if the rows below it fit.
            if is_remark and (
                first_row is None or not has_even_rows or not _numeric(first_row, mark)
            ):
                continue
            yield layout, has_even_rows


class _NamedColumns(NamedTuple):
    """Headings of all columns of a table, and the numbers (from 0) of those that are read."""

    names: list[str]
    used: tuple[int, ...]


def _layout_with_headings(
    request: _Request,
    lines: list[Line],
    index: int,
    mark: str | None,
    columns: _NamedColumns,
    may_skip_lines: bool,
) -> tuple[_Layout, str | None]:
    """Layout of a text table whose headings stand in `lines[index]`, cut by the separator `mark`;
    and the text of its first row, None where there is none.

    Units are looked for in lines below the headings, in the headings, and in lines above.
    `may_skip_lines`: whether other lines may stand between headings and rows.
    """
    line_number = lines[index][0]
    n_columns = len(columns.names)
    lines_below = [line for line in lines[index + 1 :] if not line[1].startswith(_REMARK_MARKS)]
    lines_above = [line for line in lines[:index] if not line[1].startswith(_REMARK_MARKS)]
    below_headings = _below_headings(lines_below, mark, columns.used, n_columns, may_skip_lines)
    units_above = _labelled_units(lines_above, mark, n_columns)
    units = [
        unit_below or unit_in(name)[1] or unit_above
        for unit_below, name, unit_above in zip(
            below_headings.units, columns.names, units_above, strict=True
        )
    ]
    number_of_first_row = line_number + 1
    first_row = None
    if below_headings.rows:
        number_of_first_row, first_row = below_headings.rows[0]
    layout = _Layout(
        separator=mark,
        names=tuple(columns.names),
        units=tuple(units),
        used=columns.used,
        head=line_number,
        first=number_of_first_row,
        skipped=len(lines_above),
        between=below_headings.between,
        clock=_place_of_time(request, columns.names, columns.used),
    )
    return layout, first_row


class _Below(NamedTuple):
    """The lines below headings: units (n_columns,) that stand in a line of their own, numbers of
    lines without numbers, and the lines from the first row on.
    """

    units: list[str]
    between: tuple[int, ...]
    rows: list[Line]


def _below_headings(
    lines: list[Line],
    mark: str | None,
    columns_read: Sequence[int],
    n_headings: int,
    may_skip: bool,
) -> _Below:
    """Find the line of units, if there is one, and the first row of numbers among the lines below
    the headings of a text table.

    Parameters
    ----------
    lines
        below the headings, without remarks
    mark
        separator; None for blanks
    columns_read
        numbers (from 0) of the columns that are read: a row has a number in one of them
    n_headings
        number of headings
    may_skip
        whether lines that hold neither units nor numbers may stand between
    """
    units = [""] * n_headings
    skipped_lines: list[int] = []
    for index, (number, text) in enumerate(lines):
        cells = _cells(text, mark)
        if _has_number(text, mark, columns_read):
            return _Below(units, tuple(skipped_lines), lines[index:])
        unit_cells = [cell.strip("[](){}<> ").strip("-") for cell in cells]
        has_cell_for_headings = len(cells) == n_headings or (
            mark is not None and len(cells) < n_headings
        )
        if has_cell_for_headings and not any(units) and _are_units(cells):
            units = unit_cells + [""] * (n_headings - len(cells))
        elif may_skip:
            skipped_lines.append(number)
        else:
            return _Below(units, (), lines[index:])
    # No row of numbers: the lines below are reported as rows at fault.
    return _Below([""] * n_headings, (), lines)


def _labelled_units(lines: list[Line], mark: str | None, count: int) -> list[str]:
    """Units of `count` columns from a line above the rows whose first cell says "units", as
    oscilloscopes and LabVIEW write it; empty texts where there is none.

    The line has a unit for each column but the first, or the volts of an instrument for all.

    >>> _labelled_units([(1, "Horizontal Units,s"), (2, "Vertical Units,V,V")], ",", 3)
    ['', 'V', 'V']
    >>> _labelled_units([(1, "Vertical Units,V,,-1.0,5.1,Vertical Units,V,,-1.0,0.2")], ",", 2)
    ['V', 'V']
    """
    units = [""] * count
    n_found = 0
    for _, text in lines:
        label, *cells = _cells(text, mark)
        if not _WORDS_FOR_UNITS.search(plain(label).lower()) or not cells:
            continue
        has_numbers = any(_is_number_or_time(cell, mark) for cell in cells)
        if n_found < len(cells) < count and _are_units(cells) and not has_numbers:
            n_found = len(cells)
            units[1:] = cells + [""] * (count - 1 - n_found)
        elif not n_found and cells[0].lower() in _RAW_UNITS:
            units = [cells[0]] * count
    return units


def _are_units(cells: Sequence[str]) -> bool:
    """Whether the cells of a line in a text table are units: all stand in brackets, or one at least
    is a known unit or a raw one of an instrument, such as volts.

    >>> _are_units(["s", "kN", "-"]), _are_units(["(s)", "(V)"]), _are_units(["a", "b"])
    (True, True, False)
    """
    words = [cell.strip("[](){}<> ") for cell in cells]
    in_brackets = [cell[:1] in "[({<" and cell[-1:] in "])}>" for cell in cells if cell]
    if in_brackets and all(in_brackets):
        return True
    return any(is_unit(word) or word.lower() in _RAW_UNITS for word in words)


def _is_number_or_time(cell: str, mark: str | None) -> bool:
    return _number(cell, mark != "," and "," in cell) is not None or is_clock_time(cell)


def _fits(row: str, mark: str | None, used: Sequence[int], count: int) -> bool:
    """Whether a row has a cell for each of `count` headings. Between separators that are no blanks
    the last cells may be left out, but for those that are read.
    """
    n_cells = len(_cells(row, mark))
    if mark is None:
        return n_cells == count
    return max(used) < n_cells <= count


def _has_number(row: str, mark: str | None, used: Sequence[int]) -> bool:
    """Whether a column that is read holds a number in this row: the separator is right."""
    cells = _cells(row, mark)
    return any(_is_number_or_time(cells[k], mark) for k in used if k < len(cells))


def _place_of_time(request: _Request, names: Sequence[str], used: tuple[int, ...]) -> int | None:
    """Which column may hold times of day: the one of time."""
    if "time" in request.columns:
        return used[request.columns.index("time")]
    if request.columns:
        return None
    times = {plain(alias) for alias in ALIASES["time"]}
    return next((k for k, name in enumerate(names) if plain(name) in times), None)


def _used(request: _Request, line_number: int, headings: Sequence[str]) -> tuple[int, ...] | None:
    """Match the columns that are asked for with the headings of a line: number (from 0) of the
    heading of each; None where one is not found, or one heading would stand for two columns.

    Raises
    ------
    InputError
        Where several headings could be that of one column.
    """
    places_of_columns = [
        _places_of(column, request.stated.get(column), headings) for column in request.columns
    ]
    if not all(places_of_columns):
        return None
    used_columns: list[int] = []
    for column, places_of_column in zip(request.columns, places_of_columns, strict=True):
        if len(places_of_column) > 1:
            candidates = ", ".join(repr(headings[k]) for k in places_of_column)
            raise InputError(
                f"{request.path}, line {line_number}: {candidates} could each be {column}; say"
                f" which by columns = {{{column} = ...}}"
            )
        used_columns += places_of_column
    return tuple(used_columns) if len(set(used_columns)) == len(used_columns) else None


def _places_of(column: str, stated: str | int | None, headings: Sequence[str]) -> list[int]:
    """Numbers (from 0) of the headings that may be that of a column: as the user has `stated` it,
    by heading or by number from 1 on, else by the first of its known names that occurs.
    """
    if isinstance(stated, int):
        return [stated - 1] if stated <= len(headings) else []
    if stated is not None:
        word = stated.strip()
        return [k for k, name in enumerate(headings) if word in (name, unit_in(name)[0])]
    names_of_headings = []  # for each heading its spellings, with and without a unit
    for name in headings:
        texts = (name, unit_in(name)[0], name_without_unit(name))
        names_of_headings.append({plain(text).lower() for text in texts})
    for alias in aliases_of(column):
        places_of_alias = [
            k
            for k, names_of_heading in enumerate(names_of_headings)
            if plain(alias).lower() in names_of_heading
        ]
        if places_of_alias:
            return places_of_alias
    return []


def _plain_layout(request: _Request, lines: list[Line]) -> _Layout:
    """Layout of a text table without headings that are known: rows of numbers alone, one cell for
    each column that is asked for, or columns that the user states by number.

    `lines` are the first ones of the file, without remarks.

    Raises
    ------
    InputError
        For a file that is no such table: what is wrong with it, and what to do.
    """
    columns = request.columns
    first_text = lines[0][1]
    begins_with_rows = any(
        len(_cells(first_text, separator)) > 1 and _numeric(first_text, separator)
        for separator in SEPARATORS
    )
    if not columns:
        raise _fault_of_no_names(request, lines[0], begins_with_rows)
    first_row = _first_row(lines, len(columns))
    if request.by_number:
        stated_places = [int(request.stated[name]) - 1 for name in columns]
        first_row = _first_row_with_numbers(lines, stated_places) or first_row
    row_index, _, cells_of_row = first_row
    has_cell_for_column = (
        row_index == 0
        and len(cells_of_row) == len(columns)
        and not any(isinstance(heading, str) for heading in request.stated.values())
    )
    if cells_of_row and (request.by_number or has_cell_for_column):
        return _layout_of_rows(request, lines, first_row)
    if begins_with_rows:
        raise _fault_of_count(request, lines[0], len(cells_of_row))
    raise _fault_of_headings(request, lines)


def _layout_of_rows(request: _Request, lines: list[Line], first_row: FirstRow) -> _Layout:
    """Layout of a text table whose columns are taken by number, or in the order in which they are
    asked for, from its first row on; headings and units from lines above, where there are some.

    Raises
    ------
    InputError
        For a number of a column beyond the cells of the row.
    """
    row_index, separator, cells_of_row = first_row
    columns = request.columns
    n_cells = len(cells_of_row)
    used_columns = tuple(range(len(columns)))
    if request.by_number:
        used_columns = tuple(int(request.stated[name]) - 1 for name in columns)
    if max(used_columns) >= n_cells:
        raise InputError(
            f"{request.path}, line {lines[row_index][0]}: there is no column"
            f" {max(used_columns) + 1}: the line has {n_cells}"
        )
    column_names = dict(zip(used_columns, columns, strict=True))
    names = [column_names.get(k, f"column {k + 1}") for k in range(n_cells)]
    heading_line, headings, units = _above(lines[:row_index], separator, n_cells)
    labelled_units = _labelled_units(lines, separator, n_cells)
    units = units or ("",) * n_cells
    units = tuple(unit or labelled for unit, labelled in zip(units, labelled_units, strict=True))
    n_skipped = row_index
    if heading_line:
        n_skipped = sum(line[0] < heading_line for line in lines)
    return _Layout(
        separator,
        headings or tuple(names),
        units,
        used_columns,
        heading_line,
        lines[row_index][0],
        n_skipped,
        clock=_place_of_time(request, names, used_columns),
    )


def _fault_of_no_names(request: _Request, first_line: Line, begins_with_rows: bool) -> InputError:
    """Error for a text table without headings where no columns are asked for by number: its first
    line must name the columns.
    """
    number, text = first_line
    fault = f"it is {shown(text)}"
    if begins_with_rows or _numeric(text, None):
        fault = "it has numbers only"
    advice = ""
    if request.kind.keys_by_number and begins_with_rows:
        advice = f"; or take them by number: {request.kind.keys_by_number}"
    return InputError(
        f"{request.path}, line {number}: the first line must name the columns, such as"
        f" {request.kind.example}; {fault}{advice}"
    )


def _fault_of_count(request: _Request, first_line: Line, n_cells: int) -> InputError:
    """Error for a text table of numbers alone whose rows have another number of cells, `n_cells`,
    than there are columns asked for.
    """
    number, text = first_line
    columns = request.columns
    advice = ""
    if n_cells == 2 * len(columns):
        advice = "; semicolons between the columns where commas stand in the numbers"
    numbered_columns = ", ".join(f"{name} = {k}" for k, name in enumerate(columns, 1))
    return InputError(
        f"{request.path}, line {number}: {len(columns)} numbers ({', '.join(columns)}) are needed,"
        f" not {shown(text)}{advice}; or say which by columns = {{{numbered_columns}}}"
    )


def _fault_of_headings(request: _Request, lines: list[Line]) -> InputError:
    """Error for a text table in whose headings the columns that are asked for are not found: which
    are lacking, and how to state them.
    """
    columns = request.columns
    list_of_columns = ", ".join(columns)
    (number, text), names = _likeliest_headings(request, lines)
    lacking_columns = [name for name in columns if not _is_among(request, name, names)]
    if not lacking_columns and len(names) >= len(columns):
        return InputError(
            f"{request.path}, line {number}: columns: {list_of_columns} must be of different"
            f" columns of {shown(text)}"
        )
    stated_headings = [
        shown(request.stated[name]) for name in lacking_columns if name in request.stated
    ]
    reason = f"none is known as {' or '.join(lacking_columns or columns)}"
    if stated_headings:
        reason = f"no heading is {' or '.join(stated_headings)}"
    return MissingColumnError(
        lacking_columns or columns,
        names,
        f"{request.path}, line {number}: the columns are {list_of_columns}, not {shown(text)}:"
        f" {reason}; say which by columns = {{{(lacking_columns or columns)[0]} = ...}}, by its"
        " heading or its number from 1 on",
    )


def _is_among(request: _Request, column: str, headings: Sequence[str]) -> bool:
    """Whether a heading is that of a column."""
    return bool(_places_of(column, request.stated.get(column), headings))


def _likeliest_headings(request: _Request, lines: list[Line]) -> tuple[Line, list[str]]:
    """The line of a text table that probably has its headings, and its cells, for a message on
    columns that are not found.

    It is the line above the rows in which most of the columns are found. Where none is found, it is
    the line above the first row of numbers, or above its units, else the first line.
    """
    for fewest_cells in (len(request.columns), 2, 1):
        row_index, mark, cells = _first_row(lines, fewest_cells)
        if cells:
            break
    separators = (mark,) if cells else tuple(SEPARATORS)
    best_line = lines[max(row_index - 1, 0)]
    if row_index > 1 and _are_units(_cells(best_line[1], mark)):
        best_line = lines[row_index - 2]
    best_names = max(
        (
            cells_of_line
            for separator in separators
            for cells_of_line in _headings(best_line[1], separator)
        ),
        key=len,
    )
    most_found = 0
    for line in lines[:row_index]:
        for separator in separators:
            for names in _headings(line[1], separator):
                n_found = sum(_is_among(request, column, names) for column in request.columns)
                if n_found > most_found:
                    most_found = n_found
                    best_line = line
                    best_names = names
    return best_line, best_names


def _first_row(lines: list[Line], count: int) -> FirstRow:
    """Find the first line that is a row of `count` numbers or more by any separator: its index,
    separator and cells; 0, None and no cells where there is none.
    """
    for k, (_, text) in enumerate(lines):
        for mark in SEPARATORS:
            cells = _cells(text, mark)
            if _numeric(text, mark) and len(cells) >= count:
                return k, mark, cells
    return 0, None, []


def _first_row_with_numbers(lines: list[Line], places: Sequence[int]) -> FirstRow | None:
    """Find the first line that has numbers in the cells at given `places` (from 0), as the next one
    has, whatever stands in other cells: its index, separator and cells; None where there is none.

    >>> rows = [(1, "Model,7,,0.0,5.1"), (2, "Source,CH1,,0.1,5.2"), (3, ",,,0.2,5.3")]
    >>> _first_row_with_numbers(rows, [3, 4])
    (0, ',', ['Model', '7', '', '0.0', '5.1'])
    """

    def has_numbers(text: str, mark: str | None) -> bool:
        cells = _cells(text, mark)
        return max(places) < len(cells) and all(
            _is_number_or_time(cells[place], mark) for place in places
        )

    for mark in SEPARATORS:
        for k, (row, next_row) in enumerate(pairwise([text for _, text in lines])):
            if has_numbers(row, mark) and has_numbers(next_row, mark):
                return k, mark, _cells(row, mark)
    return None


def _above(
    lines: list[Line], mark: str | None, n_columns: int
) -> tuple[int, tuple[str, ...], tuple[str, ...]]:
    """Headings and units of a text table whose columns are taken by number, from the last lines
    above its rows: number of the line of headings, headings and units (n_columns,).

    0 and empty tuples where the line just above the rows has no cell for each column.
    """
    lines_of_headings = [
        (number, cells_of_line)
        for number, text in lines
        for cells_of_line in _headings(text, mark)
        if len(cells_of_line) == n_columns
    ]
    units = [""] * n_columns
    if len(lines_of_headings) > 1 and _are_units(lines_of_headings[-1][1]):
        units = [cell.strip("[](){}<> ") for cell in lines_of_headings[-1][1]]
        lines_of_headings.pop()
    if not lines_of_headings or lines_of_headings[-1][0] < lines[-1][0] - 1:
        return 0, (), ()
    number, names = lines_of_headings[-1]
    units_of_names = [unit or unit_in(name)[1] for unit, name in zip(units, names, strict=True)]
    return number, tuple(names), tuple(units_of_names)


def _has_decimal_comma(lines: Iterator[Line], layout: _Layout) -> bool:
    """Whether a comma is the decimal sign of a text table: the first row decides that has a comma
    or a point in a column that is read. Times of day do not count.

    In a cell with both signs the later one is the decimal sign; the other stands between thousands.
    """
    for number, text in lines:
        if number < layout.first or not ("," in text or "." in text):
            continue
        cells = _cells(text, layout.separator)
        used_cells = [cells[k] for k in layout.used if k < len(cells)]
        used_cells = [cell for cell in used_cells if not is_clock_time(cell)]
        has_point = any("." in cell for cell in used_cells)
        has_comma = any("," in cell for cell in used_cells)
        if has_point or has_comma:
            return has_comma and (
                not has_point or any(0 <= cell.find(".") < cell.rfind(",") for cell in used_cells)
            )
    return False


@dataclass(frozen=True, eq=False)
class _Rows:
    """The numbers (n, m) of the columns that are read, the line (n,) of each row; lines that are no
    rows, in words; the first cell of a column of times of day.
    """

    values: Array
    lines: NDArray[np.int64]
    left_out: tuple[str, ...] = ()
    clock_start: str = ""


@dataclass(eq=False)
class _RowReader:
    """Streams the rows of a text table, so that only their numbers take memory.

    Attributes
    ----------
    request
        file, columns and kind of the table
    read_lines
        yields the lines of the file from the first one on at each call
    layout
        where headings and rows stand, and the separator
    has_decimal_comma
        whether the decimal sign is a comma
    line_numbers
        of the rows that were streamed last
    """

    request: _Request
    read_lines: Callable[[], Iterator[Line]]
    layout: _Layout
    has_decimal_comma: bool
    line_numbers: array[int] = field(default_factory=lambda: array("q"))

    def lines(self) -> Iterator[Line]:
        """The lines from the first row on, without remarks, with their numbers in the file;
        InputError for more rows than are read.
        """
        may_have_remarks = bool(self.request.columns)
        line_numbers = self.line_numbers
        first_line = self.layout.first
        del line_numbers[:]
        for number, text in self.read_lines():
            if number < first_line or text.startswith(_REMARK_MARKS):
                continue
            if len(line_numbers) == MOST_ROWS:
                raise InputError(
                    f"{self.request.path}: {self.request.kind.role} has more than {MOST_ROWS:,}"
                    f" rows, the most that are read; {self.request.kind.cure}"
                )
            line_numbers.append(number)
            if may_have_remarks and "#" in text:
                yield number, text.split("#", 1)[0].rstrip()
            else:
                yield number, text

    def even_rows(self) -> Iterator[str]:
        """The rows as numpy's loadtxt takes them, with a decimal point; ValueError for a row with
        another number of cells, or with a point in a table with decimal commas.
        """
        mark = self.layout.separator
        has_decimal_comma = self.has_decimal_comma
        most_separators = len(self.layout.names) - 1
        fewest_separators = most_separators if mark is None else max(self.layout.used)
        for _, text in self.lines():
            # Empty cells at the end of a line are none.
            row = text if mark is None else text.rstrip(f"{mark} ")
            separator_count = len(row.split()) - 1 if mark is None else row.count(mark)
            is_even = fewest_separators <= separator_count <= most_separators
            if not is_even or (has_decimal_comma and "." in row):
                raise ValueError
            yield row.replace(",", ".") if has_decimal_comma else row


def _numbers(
    request: _Request, lines: Callable[[], Iterator[Line]], layout: _Layout, has_decimal_comma: bool
) -> _Rows:
    """Read the rows of numbers of a text table, all at once by numpy; where that fails, cell by
    cell up to the fault.

    Parameters
    ----------
    request
        file, columns and kind of the table
    lines
        yields the lines of the file from the first one on at each call
    layout
        where headings and rows stand, and the separator
    has_decimal_comma
        whether the decimal sign is a comma

    Raises
    ------
    InputError
        For a table without rows, and for the first row with a fault.
    """
    reader = _RowReader(request, lines, layout, has_decimal_comma)
    if next(reader.lines(), None) is None:
        headings = ", ".join(layout.names[k] for k in layout.used[:6])
        rest_text = ", ..." if len(layout.used) > 6 else ""
        raise InputError(f"{request.path}: no row of numbers below the names {headings}{rest_text}")
    try:
        values = np.loadtxt(
            reader.even_rows(),
            delimiter=layout.separator,
            comments=None,
            ndmin=2,
            usecols=layout.used,
        )
    except InputError:
        raise
    except ValueError:
        values = np.array([[np.nan]])
    if (np.abs(values) <= LARGEST).all():
        return _Rows(values, np.array(reader.line_numbers, dtype=np.int64))
    return _numbers_cell_by_cell(request.path, reader.lines(), layout, has_decimal_comma)


def _numbers_cell_by_cell(path: Path, rows: Iterator[Line], layout: _Layout, comma: bool) -> _Rows:
    """Read the rows of a text table cell by cell: times of day become seconds, and lines of text
    behind the last row, or that repeat the headings, are left out and reported.

    Parameters
    ----------
    path
        of the file, for messages
    rows
        number and text of the lines from the first row on
    layout
        headings, separator and columns that are read
    comma
        whether the decimal sign is a comma

    Raises
    ------
    InputError
        For the first row with a fault: another number of cells, or a cell that is no number.
    """
    clock = ClockColumn()
    values = array("d")
    line_numbers = array("q")
    text_since_last_row: list[Line] = []
    lines_with_headings: list[int] = []
    for line, text in rows:
        cells = _cells(text, layout.separator)
        if cells == [name.strip() for name in layout.names]:
            lines_with_headings.append(line)
            continue
        if _is_text(cells, layout, comma):
            text_since_last_row.append((line, text))
            continue
        if text_since_last_row:  # text between rows is refused as a row at fault
            _row(path, *text_since_last_row[0], layout, comma, clock)
        values.extend(_row(path, line, text, layout, comma, clock))
        line_numbers.append(line)
    if not line_numbers:
        _row(path, *text_since_last_row[0], layout, comma, clock)
    left_out = []
    if lines_with_headings:
        left_out.append(
            f"line {', '.join(map(str, lines_with_headings[:5]))}: the headings once more"
        )
    if text_since_last_row:
        line, text = text_since_last_row[0]
        line_count = (
            "1 line" if len(text_since_last_row) == 1 else f"{len(text_since_last_row)} lines"
        )
        left_out.append(f"{line_count} behind the rows, from line {line} on: {shown(text)}")
    return _Rows(
        np.array(values).reshape(-1, len(layout.used)),
        np.array(line_numbers, dtype=np.int64),
        tuple(left_out),
        clock.first_text,
    )


def _is_text(cells: Sequence[str], layout: _Layout, comma: bool) -> bool:
    """Whether a line is text and no row: a word stands in the first column that is read."""
    place = layout.used[0]
    first_cell = cells[place] if place < len(cells) else cells[0]
    return (
        first_cell[:1].isalpha()
        and _number(first_cell, comma) is None
        and not is_clock_time(first_cell)
    )


def _row(
    path: Path, line: int, line_text: str, layout: _Layout, comma: bool, clock: ClockColumn
) -> list[float]:
    """Read one line of a text table: the numbers of the columns that are read, a time of day as
    seconds since the first row.

    Parameters
    ----------
    path, line, line_text
        file, number of the line for messages, and its text
    layout
        names, separator and used columns of the table
    comma
        whether the decimal sign is a comma
    clock
        turns times of day into seconds

    Raises
    ------
    InputError
        For another number of cells than of headings, or a cell that is no finite number.
    """
    cells = _cells(line_text, layout.separator)
    if not _fits(line_text, layout.separator, layout.used, len(layout.names)):
        list_of_names = ", ".join(layout.names[:6]) + (", ..." if len(layout.names) > 6 else "")
        advice = ""
        if layout.separator == "," and len(cells) > len(layout.names):
            advice = (
                "; commas between the columns leave points for the numbers, without marks between"
                " thousands"
            )
        raise InputError(
            f"{path}, line {line}: {len(layout.names)} numbers ({list_of_names}) are needed, not"
            f" {shown(line_text)}{advice}"
        )
    numbers: list[float] = []
    for column in layout.used:
        number = _number(cells[column], comma)
        advice = ""
        if number is None and column == layout.clock:
            try:
                number = clock.seconds(cells[column])
            except ValueError as reason:
                advice = f": {reason}"
        if number is None or not abs(number) <= LARGEST:
            if _GROUPED_DIGITS.match(cells[column]):
                advice = (
                    f"; the decimal sign of this file is a {'comma' if comma else 'point'}: write"
                    " no marks between thousands"
                )
            elif not cells[column]:
                advice = ": fill it in, or take out the line"
            elif column == layout.clock and not advice:
                advice = f", nor a time such as {WORDS}"
            raise InputError(
                f"{path}, line {line}: {layout.names[column]} = {shown(cells[column])} is not a"
                f" finite number of at most {LARGEST:g}{advice}"
            )
        numbers.append(number)
    return numbers
