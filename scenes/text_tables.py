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
from dataclasses import dataclass
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
_LONGEST = 100_000
_LONGEST_OF_ALL = 10_000_000
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
_MARKS_OF_16 = (b"\xff\xfe", b"\xfe\xff")
# Of every second byte: European text in UTF-16 has more zeros than that in one half, no other has.
_ZEROS_OF_16 = 0.8
# What an instrument writes where a unit stands, which is none of a load or a length.
_RAW = ("v", "mv", "volt", "volts", "bit", "counts", "div")
# A line that has units, in the languages of `column_names`.
_OF_UNITS = re.compile(r"unit|einheit|unidad")
# Lines that are looked at before the table is read, bytes that show what it is written in.
_LOOK = 200
_START = 50_000
# How a file begins that is JSON, XML or HTML: no heading does.
_MARKUP = re.compile(r"\s*(?:\{|\[\s*(?:[\[{\"\d-]|$)|<[?!\w])")
_REMARKS = ("#", "**", "%", "//")
SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma", None: "blanks"}
# A number whose digits stand in groups of three: 1,234.5 or 1.234,5 or 1 234 or 1'234.
_GROUPED = re.compile(r"[-+]?\d{1,3}([.,'’ \u00a0\u202f]\d{3})+([.,]\d*)?$")


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
    """Rows of finite numbers below a line of headings; lines that start with #, **, % or // are
    remarks.

    Parameters
    ----------
    path
        the file
    columns
        names that are asked for, found by the headings that are known for each; the line of
        headings may be left out where the file has these columns alone, in this order, and a #
        in a row begins a remark. Without: every column
    stated
        heading, or number from 1 on, of columns that the user named
    kind
        what the table is, for its headings and for the sentences

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
    longest_line = _LONGEST if columns else _LONGEST_OF_ALL
    try:
        check_size(path, kind.role, TEXT, kind.cure)
        with path.open("rb") as binary:
            first_bytes = binary.read(_START)
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
    """The table in the lines of a file, which `read_lines` yields from the first one on at each
    call.

    Raises
    ------
    InputError
        One sentence on the first line that does not fit.
    """
    first_lines = list(islice(read_lines(), _LOOK))
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
    """What the first bytes of a file may be written in, the likeliest first.

    >>> _encodings_of("Zeit;P".encode("utf-16-le")), _encodings_of(b"time,P")
    (['utf-16-le'], ['utf-8-sig', 'cp1252', 'cp932', 'latin-1'])
    """
    if start.startswith(_MARKS_OF_16):
        return ["utf-16"]
    if b"\0" not in start:
        return ["utf-8-sig", "cp1252", "cp932", "latin-1"]
    pairs = max(len(start) // 2, 1)
    if start[1::2].count(0) > _ZEROS_OF_16 * pairs:
        return ["utf-16-le"]
    if start[0::2].count(0) > _ZEROS_OF_16 * pairs:
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
    """Number and text of every line that is not empty, from the first on."""
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
        _is_number_or_time(cell, separator) or _GROUPED.match(cell)
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
    """The layout of a file that begins with a row of two numbers or more; None for another."""
    lines_without_remarks = [
        (number, text) for number, text in lines if not text.startswith(_REMARKS)
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
    """Where headings, units and rows of the table stand in the file, from its first `lines`.

    Without columns asked for, a line with two known headings is looked for first, then the first
    line of two words or more. Where no line has headings, the rows may stand alone.

    Raises
    ------
    InputError
        For a file that has no such table.
    """
    path = request.path
    columns = request.columns
    lines_without_remarks = [line for line in lines if not line[1].startswith(_REMARKS)]
    needed_text = "a line of names and rows of numbers"
    if columns:
        needed_text = f"{len(columns)} columns {', '.join(columns)}"
    if not lines_without_remarks:
        raise InputError(f"{path}: the file is empty; {needed_text} are needed")
    if _MARKUP.match(lines_without_remarks[0][1]):
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
        # Rows without a cell for each heading: a fault of theirs, if nothing else fits. A line of
        # text that is cut by another mark than the rows has no headings of theirs.
        _, mark_of_rows, cells_of_row = _first_row(lines_without_remarks, max(len(columns), 2))
        for layout in layouts_with_uneven_rows:
            if not cells_of_row or layout.separator == mark_of_rows:
                return layout
    return _plain_layout(request, lines_without_remarks)


def _is_row(text: str, fewest_cells: int) -> bool:
    """Whether a line is a row of numbers by any separator, and no remark."""
    return not text.startswith(_REMARKS) and any(
        len(_cells(text, mark)) >= fewest_cells and _numeric(text, mark) for mark in SEPARATORS
    )


def _layouts_below(
    request: _Request, lines: list[Line], index: int, fewest_known: int
) -> Iterator[tuple[_Layout, bool]]:
    """The layouts that a table has if `lines[index]` has its headings, one for each way to cut the
    line; and whether the first row has a cell for each heading.

    `fewest_known` of the headings must be known where no columns are asked for.
    """
    line_number, text = lines[index]
    is_remark = text.startswith(_REMARKS)
    heading_text = text.lstrip("#*%/ ") if is_remark else text
    lines_below = [line for line in lines[index + 1 :] if not line[1].startswith(_REMARKS)]
    lines_above = [line for line in lines[:index] if not line[1].startswith(_REMARKS)]
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
            below_headings = _below_headings(
                lines_below, mark, used_columns, len(names), may_skip_lines
            )
            units = [
                unit_below or unit_in(name)[1] or unit_above
                for unit_below, name, unit_above in zip(
                    below_headings.units,
                    names,
                    _labelled_units(lines_above, mark, len(names)),
                    strict=True,
                )
            ]
            first_row = below_headings.rows[0][1] if below_headings.rows else None
            number_of_first_row = (
                below_headings.rows[0][0] if below_headings.rows else line_number + 1
            )
            has_even_rows = first_row is None or (
                _fits(first_row, mark, used_columns, len(names))
                and _has_number(first_row, mark, used_columns)
            )
            if is_remark and (
                first_row is None or not has_even_rows or not _numeric(first_row, mark)
            ):
                continue
            layout = _Layout(
                separator=mark,
                names=tuple(names),
                units=tuple(units),
                used=used_columns,
                head=line_number,
                first=number_of_first_row,
                skipped=len(lines_above),
                between=below_headings.between,
                clock=_place_of_time(request, names, used_columns),
            )
            yield layout, has_even_rows


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
    """Units and rows in the lines below `n_headings` headings, `columns_read` of which are read.
    `may_skip` is whether lines that hold
    neither units nor numbers may stand between; a row has a number in a column that is read.
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
    # no row of numbers: what stands below is at fault
    return _Below([""] * n_headings, (), lines)


def _labelled_units(lines: list[Line], mark: str | None, count: int) -> list[str]:
    """Units of `count` columns from a line that says so in its first cell, as oscilloscopes and
    LabVIEW write it: one for each column behind the first, or volts for all; else empty ones.

    >>> _labelled_units([(1, "Horizontal Units,s"), (2, "Vertical Units,V,V")], ",", 3)
    ['', 'V', 'V']
    >>> _labelled_units([(1, "Vertical Units,V,,-1.0,5.1,Vertical Units,V,,-1.0,0.2")], ",", 2)
    ['V', 'V']
    """
    units = [""] * count
    n_found = 0
    for _, text in lines:
        label, *cells = _cells(text, mark)
        if not _OF_UNITS.search(plain(label).lower()) or not cells:
            continue
        has_numbers = any(_is_number_or_time(cell, mark) for cell in cells)
        if n_found < len(cells) < count and _are_units(cells) and not has_numbers:
            n_found = len(cells)
            units[1:] = cells + [""] * (count - 1 - n_found)
        elif not n_found and cells[0].lower() in _RAW:
            units = [cells[0]] * count
    return units


def _are_units(cells: Sequence[str]) -> bool:
    """Whether the cells of a line are units: one at least is known or what an instrument writes, or
    all stand in brackets.

    >>> _are_units(["s", "kN", "-"]), _are_units(["(s)", "(V)"]), _are_units(["a", "b"])
    (True, True, False)
    """
    words = [cell.strip("[](){}<> ") for cell in cells]
    in_brackets = [cell[:1] in "[({<" and cell[-1:] in "])}>" for cell in cells if cell]
    if in_brackets and all(in_brackets):
        return True
    return any(is_unit(word) or word.lower() in _RAW for word in words)


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
    """Which of the headings of a line is that of each wanted column; None where one is not found or
    one stands for two columns.

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
    """Indices of the headings that may be that of a column: as stated, else by its aliases."""
    if isinstance(stated, int):
        return [stated - 1] if stated <= len(headings) else []
    if stated is not None:
        word = stated.strip()
        return [k for k, name in enumerate(headings) if word in (name, unit_in(name)[0])]
    names_of_headings = []  # of each heading, with and without what may be its unit
    for name in headings:
        texts = (name, unit_in(name)[0], name_without_unit(name))
        names_of_headings.append({plain(text).lower() for text in texts})
    for alias in aliases_of(column):
        found_places = [
            k
            for k, names_of_heading in enumerate(names_of_headings)
            if plain(alias).lower() in names_of_heading
        ]
        if found_places:
            return found_places
    return []


def _plain_layout(request: _Request, lines: list[Line]) -> _Layout:
    """The layout of a table whose `lines` have no line of headings that was recognised: rows of
    numbers alone, one cell for each column that is asked for, or columns by number.

    Raises
    ------
    InputError
        For a file that is no such table: what is wrong with it.
    """
    path = request.path
    columns = request.columns
    number, text = lines[0]
    begins_with_rows = any(
        len(_cells(text, separator)) > 1 and _numeric(text, separator) for separator in SEPARATORS
    )
    if not columns:
        fault = f"it is {shown(text)}"
        if begins_with_rows or _numeric(text, None):
            fault = "it has numbers only"
        keys_of_columns = request.kind.keys_by_number
        advice = (
            f"; or take them by number: {keys_of_columns}"
            if keys_of_columns and begins_with_rows
            else ""
        )
        raise InputError(
            f"{path}, line {number}: the first line must name the columns, such as"
            f" {request.kind.example}; {fault}{advice}"
        )
    list_of_columns = ", ".join(columns)
    n_columns = len(columns)
    row_index, separator, cells_of_row = _first_row(lines, n_columns)
    if request.by_number:
        stated_places = [int(request.stated[name]) - 1 for name in columns]
        row_index, separator, cells_of_row = _first_row_with_numbers(lines, stated_places) or (
            row_index,
            separator,
            cells_of_row,
        )
    has_cell_for_column = (
        row_index == 0
        and len(cells_of_row) == n_columns
        and not any(isinstance(heading, str) for heading in request.stated.values())
    )
    if cells_of_row and (request.by_number or has_cell_for_column):
        used_columns = tuple(range(n_columns))
        if request.by_number:
            used_columns = tuple(int(request.stated[name]) - 1 for name in columns)
        if max(used_columns) >= len(cells_of_row):
            raise InputError(
                f"{path}, line {lines[row_index][0]}: there is no column {max(used_columns) + 1}:"
                f" the line has {len(cells_of_row)}"
            )
        column_names = dict(zip(used_columns, columns, strict=True))
        names = [column_names.get(k, f"column {k + 1}") for k in range(len(cells_of_row))]
        heading_line, headings, units = _above(lines[:row_index], separator, len(cells_of_row))
        labelled_units = _labelled_units(lines, separator, len(cells_of_row))
        units = units or ("",) * len(cells_of_row)
        units = tuple(
            unit or labelled for unit, labelled in zip(units, labelled_units, strict=True)
        )
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
    if begins_with_rows:
        advice = ""
        if len(cells_of_row) == 2 * n_columns:
            advice = "; semicolons between the columns where commas stand in the numbers"
        raise InputError(
            f"{path}, line {number}: {n_columns} numbers ({list_of_columns}) are needed, not"
            f" {shown(text)}{advice}; or say which by columns ="
            f" {{{', '.join(f'{name} = {k}' for k, name in enumerate(columns, 1))}}}"
        )
    (number, text), names = _likeliest_headings(request, lines)
    lacking_columns = [name for name in columns if not _is_among(request, name, names)]
    if not lacking_columns and len(names) >= n_columns:
        raise InputError(
            f"{path}, line {number}: columns: {list_of_columns} must be of different columns of"
            f" {shown(text)}"
        )
    stated_headings = [
        shown(request.stated[name]) for name in lacking_columns if name in request.stated
    ]
    reason = f"none is known as {' or '.join(lacking_columns or columns)}"
    if stated_headings:
        reason = f"no heading is {' or '.join(stated_headings)}"
    raise MissingColumnError(
        lacking_columns or columns,
        names,
        f"{path}, line {number}: the columns are {list_of_columns}, not {shown(text)}: {reason};"
        f" say which by columns = {{{(lacking_columns or columns)[0]} = ...}}, by its heading or"
        " its"
        " number from 1 on",
    )


def _is_among(request: _Request, column: str, headings: Sequence[str]) -> bool:
    """Whether a heading is that of a column."""
    return bool(_places_of(column, request.stated.get(column), headings))


def _likeliest_headings(request: _Request, lines: list[Line]) -> tuple[Line, list[str]]:
    """The line above the rows in which most columns are found, and its cells; where none is found,
    the line above the first row of numbers, or above the units, else the first.
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


def _first_row(lines: list[Line], count: int) -> tuple[int, str | None, list[str]]:
    """Index, separator and cells of the first row of `count` numbers or more; 0, None and no cells
    where there is none.
    """
    for k, (_, text) in enumerate(lines):
        for mark in SEPARATORS:
            cells = _cells(text, mark)
            if _numeric(text, mark) and len(cells) >= count:
                return k, mark, cells
    return 0, None, []


def _first_row_with_numbers(
    lines: list[Line], places: Sequence[int]
) -> tuple[int, str | None, list[str]] | None:
    """The first line that has numbers in the cells at given `places`, whatever stands beside them,
    and so has the next: its index in `lines`, the separator, and its cells. None where there is
    none.

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
    """Line, headings and units (count,) of columns that were named by number, from the last lines
    above the rows; 0 and none.
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
    """Whether commas are the decimal sign: the first row with either sign in a column that is read
    decides, but for times of day, which have one of their own.

    Of both signs it is the later one in a cell that has both: the other one stands between
    thousands, and is refused.
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


def _numbers(
    request: _Request, lines: Callable[[], Iterator[Line]], layout: _Layout, has_decimal_comma: bool
) -> _Rows:
    """The rows of numbers of a table.

    All rows are read at once; where that fails, cell by cell up to the fault.

    Parameters
    ----------
    lines
        yields the lines of the file from the first one on at each call
    layout
        where headings and rows stand, and the separator
    has_decimal_comma
        whether the decimal sign is a comma
    """
    path = request.path
    mark = layout.separator
    most_separators = len(layout.names) - 1
    fewest_separators = most_separators if mark is None else max(layout.used)
    remarks_in_rows = bool(request.columns)
    line_numbers = array("q")

    def lines_of_rows() -> Iterator[Line]:
        """The lines from the first row on, without remarks; each line's number is stored.
        InputError for too many.
        """
        del line_numbers[:]
        for number, text in lines():
            if number < layout.first or text.startswith(_REMARKS):
                continue
            if len(line_numbers) == MOST_ROWS:
                raise InputError(
                    f"{path}: {request.kind.role} has more than {MOST_ROWS:,} rows, the most that"
                    f" are read; {request.kind.cure}"
                )
            line_numbers.append(number)
            if remarks_in_rows and "#" in text:
                yield number, text.split("#", 1)[0].rstrip()
            else:
                yield number, text

    def even_rows() -> Iterator[str]:
        """The rows as loadtxt takes them, with a decimal point; ValueError for a row with another
        count of cells, or a point in a table with decimal commas.
        """
        for _, text in lines_of_rows():
            # empty cells at the end are none
            row = text if mark is None else text.rstrip(f"{mark} ")
            separator_count = len(row.split()) - 1 if mark is None else row.count(mark)
            is_even = fewest_separators <= separator_count <= most_separators
            if not is_even or (has_decimal_comma and "." in row):
                raise ValueError
            yield row.replace(",", ".") if has_decimal_comma else row

    if next(lines_of_rows(), None) is None:
        headings = ", ".join(layout.names[k] for k in layout.used[:6])
        rest_text = ", ..." if len(layout.used) > 6 else ""
        raise InputError(f"{path}: no row of numbers below the names {headings}{rest_text}")
    try:
        values = np.loadtxt(
            even_rows(), delimiter=mark, comments=None, ndmin=2, usecols=layout.used
        )
    except InputError:
        raise
    except ValueError:
        values = np.array([[np.nan]])
    if (np.abs(values) <= LARGEST).all():
        return _Rows(values, np.array(line_numbers, dtype=np.int64))
    return _numbers_cell_by_cell(path, lines_of_rows(), layout, has_decimal_comma)


def _numbers_cell_by_cell(path: Path, rows: Iterator[Line], layout: _Layout, comma: bool) -> _Rows:
    """Numbers of a table row by row, times of day as seconds; lines that repeat the headings, and
    text behind the last row, are left out, which the result states.

    `rows` are the lines from the first row on, `comma` is whether the decimal sign is a comma.

    Raises
    ------
    InputError
        For the first row with a fault: another count of cells, or a cell that is no number.
    """
    clock = ClockColumn()
    values = array("d")
    line_numbers = array("q")
    text_since_last_row: list[Line] = []  # since the last row
    lines_with_headings: list[int] = []
    for line, text in rows:
        cells = _cells(text, layout.separator)
        if cells == [name.strip() for name in layout.names]:
            lines_with_headings.append(line)
            continue
        if _is_text(cells, layout, comma):
            text_since_last_row.append((line, text))
            continue
        if text_since_last_row:  # they are not behind the last row
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
    """Numbers of the used columns in one line of a table; a time of day as seconds since the first
    row.

    Parameters
    ----------
    path, line
        file and number of the line, for the sentence of a refusal
    layout
        names, separator and used columns of the table
    comma
        whether the decimal sign is a comma
    clock
        turns times of day into seconds

    Raises
    ------
    InputError
        For another count of cells than of columns, or a cell that is no number.
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
            if _GROUPED.match(cells[column]):
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
