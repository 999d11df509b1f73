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
from scenes.arrays import LARGEST_NUMBER
from scenes.clock_times import EXAMPLES_OF_CLOCK_TIMES, ClockColumn, is_clock_time
from scenes.column_names import ALIASES, aliases_of, normalised_name
from scenes.errors import InputError, shortened_repr
from scenes.files import LARGEST_TEXT_BYTES, require_readable_size
from scenes.unit_words import is_unit, name_without_unit, unit_in

# Rows of a table, characters of a row: what is longer would take gigabytes on its way through the
# engines. A row of somebody else's table may hold all the frames of a point.
MOST_ROWS = 2_000_000
_MOST_CHARACTERS_OF_LINE = 100_000
_MOST_CHARACTERS_WITH_ALL_COLUMNS = 10_000_000
# What a file may be written in; a mark of byte order, which spreadsheets put at the front, is no
# part of the first name or number.
_ENCODINGS_IN_WORDS = {
    "utf-8-sig": "UTF-8",
    "cp1252": "Windows-1252, since it is not UTF-8",
    "cp932": "Shift-JIS, since it is neither UTF-8 nor Windows-1252",
    "latin-1": "Latin-1, since no other set of characters fits",
    "utf-16": "UTF-16",
    "utf-16-le": "UTF-16, without its mark of byte order",
    "utf-16-be": "UTF-16, without its mark of byte order",
}
_BYTE_ORDER_MARKS_OF_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
# Of every second byte: European text in UTF-16 has more zeros than that in one half, no other has.
_LEAST_ZERO_SHARE_OF_UTF_16 = 0.8
# What an instrument writes where a unit stands, which is none of a load or a length.
_RAW_UNITS = ("v", "mv", "volt", "volts", "bit", "counts", "div")
# A line that has units, in the languages of `column_names`.
_WORDS_FOR_UNITS = re.compile(r"unit|einheit|unidad")
# Lines that are looked at before the table is read, bytes that show what it is written in.
_MOST_LINES_LOOKED_AT = 200
_MOST_BYTES_LOOKED_AT = 50_000
# How a file begins that is JSON, XML or HTML: no heading does.
_MARKUP_START = re.compile(r"\s*(?:\{|\[\s*(?:[\[{\"\d-]|$)|<[?!\w])")
_COMMENT_MARKS = ("#", "**", "%", "//")
SEPARATORS_IN_WORDS = {"\t": "tab", ";": "semicolon", ",": "comma", None: "blanks"}
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
        of the columns: the quantities to be read, else the headings
    values
        (n_rows, n_columns)
    line_numbers
        (n_rows,) number of the line of each row
    headings
        of these columns in the file; "column 2" where it has no line of headings
    units
        of these columns in the file, empty where none stands there
    separator, decimal_sign, encoding
        words
    heading_line_number
        number (from 1) of the line of headings, 0 where there is none
    n_lines_above
        number of lines above it, or above the rows, that are no comments
    unread_headings
        headings of the columns that were not read
    lines_left_out
        lines that are no rows, in words: between headings and rows, behind the rows, headings
        that are repeated
    first_clock_text
        the first cell of a column of times of day, empty where times are numbers
    """

    names: tuple[str, ...]
    values: Array
    line_numbers: NDArray[np.int64]
    headings: tuple[str, ...]
    units: tuple[str, ...]
    separator: str
    decimal_sign: str
    encoding: str
    heading_line_number: int
    n_lines_above: int
    unread_headings: tuple[str, ...] = ()
    lines_left_out: tuple[str, ...] = ()
    first_clock_text: str = ""

    def column(self, name: str) -> Array:
        """The first column of that name, (n_rows,)."""
        return np.asarray(self.values[:, self.names.index(name)])


@dataclass(frozen=True)
class _Layout:
    """Where the columns and rows of a text table stand in its file.

    Attributes
    ----------
    separator
        between cells; None for blanks
    headings
        of each of the n columns; "column 1" and so on where the file has none
    units
        (n,) as written in the file, empty where a column has none
    columns_read
        indices (from 0) of the columns that are read
    heading_line_number, first_row_line_number
        line numbers (from 1) of the headings, 0 for none, and of the first row
    n_lines_above
        lines above the headings, or above the rows of a table without headings
    numbers_of_lines_between
        numbers of the lines between headings and rows that hold neither units nor numbers
    time_column
        index (from 0) of the column that may hold times of day, None for no such column
    """

    separator: str | None
    headings: tuple[str, ...]
    units: tuple[str, ...]
    columns_read: tuple[int, ...]
    heading_line_number: int
    first_row_line_number: int
    n_lines_above: int
    numbers_of_lines_between: tuple[int, ...] = ()
    time_column: int | None = None


Line = tuple[int, str]
# Index of a row among some lines, its separator, and its cells.
FirstRow = tuple[int, str | None, list[str]]


@dataclass(frozen=True)
class TableKind:
    """What a kind of text table is to the user, and which headings it has.

    Attributes
    ----------
    role_of_file, advice_on_size
        what the file is to the user, and what to do about one that is too large
    is_expected_heading
        whether a heading is one of those expected, where every column is read
    example, keys_by_number
        headings of this kind of table, and the keys that take columns by number instead; both
        for the sentence of a refusal
    may_lack_headings
        whether rows without a line of headings are read where every column is read, as
        "column 1" and so on
    """

    role_of_file: str = "the table"
    advice_on_size: str = "thin it out"
    is_expected_heading: Callable[[str], bool] = lambda _heading: False
    example: str = "time,x,pressure,shear"
    keys_by_number: str = ""
    may_lack_headings: bool = False


@dataclass(frozen=True)
class _Request:
    """Which columns of which file the caller wants.

    Attributes
    ----------
    path
        of the file
    quantities
        to be read, such as "time"; empty for every column
    stated_columns
        quantity -> heading, or column number (from 1), where the user names its column
    kind
        what the table is to the user, and which headings it has
    """

    path: Path
    quantities: tuple[str, ...]
    stated_columns: Mapping[str, str | int]
    kind: TableKind

    @property
    def takes_columns_by_number(self) -> bool:
        """Whether the user states the column of every quantity by its number."""
        headings_or_numbers = [self.stated_columns.get(name) for name in self.quantities]
        return bool(self.quantities) and all(
            isinstance(value, int) for value in headings_or_numbers
        )

    def require_column_numbers_from_1(self) -> None:
        """Refuse a column number below 1 where the user states one: InputError."""
        for name, heading_or_number in self.stated_columns.items():
            if isinstance(heading_or_number, int) and heading_or_number < 1:
                raise InputError(
                    f"{self.path}: columns = {{{name} = {heading_or_number}}} is refused: columns"
                    " are numbered from 1 on"
                )


def text_table(
    path: Path,
    quantities: tuple[str, ...] = (),
    stated_columns: Mapping[str, str | int] | None = None,
    kind: TableKind = TableKind(),
) -> TextTable:
    """Read columns of numbers from a text file of another program, whatever its separator, decimal
    sign, encoding and headings.

    Lines that start with #, **, % or // are comments and are skipped.

    Parameters
    ----------
    path
        of the file
    quantities
        those to be read, such as "time" or "normal_load". The column of each is found by its
        usual headings, listed in `column_names`. A file of these columns alone, in this order,
        needs no headings, and a # in a row begins a comment. Empty: every column is read
    stated_columns
        quantity -> heading of its column, or column number (from 1), where the user names it
    kind
        what the table is to the user, and what to do about one that is too large (`role_of_file`,
        `advice_on_size`), for messages; and which headings to expect where `quantities` is empty

    Raises
    ------
    InputError
        One sentence that names file, line, column, value and rule.
    """
    request = _Request(path, quantities, stated_columns or {}, kind)
    request.require_column_numbers_from_1()
    # _MOST_CHARACTERS_OF_LINE, _MOST_CHARACTERS_WITH_ALL_COLUMNS: 100,000, and 10,000,000 for
    # tables of all columns
    most_characters = _MOST_CHARACTERS_OF_LINE if quantities else _MOST_CHARACTERS_WITH_ALL_COLUMNS
    try:
        # LARGEST_TEXT_BYTES: 268 MB
        require_readable_size(path, kind.role_of_file, LARGEST_TEXT_BYTES, kind.advice_on_size)
        with path.open("rb") as binary_stream:
            # _MOST_BYTES_LOOKED_AT: the first 50,000
            first_bytes = binary_stream.read(_MOST_BYTES_LOOKED_AT)
        # Character encodings that the file may have, likeliest first; each is tried in turn.
        encodings = _encodings_of(first_bytes)
        is_utf_16 = encodings[0].startswith("utf-16")
        for encoding in encodings:
            with contextlib.suppress(UnicodeError), path.open(encoding=encoding) as stream:
                # Yields number and text of the lines, from the first one on at each call.
                read_lines = partial(_numbered_lines, path, stream, most_characters)
                # _ENCODINGS_IN_WORDS: names of the encodings for the user
                return _table_in_lines(request, read_lines, _ENCODINGS_IN_WORDS[encoding])
    except OSError as reason:
        raise InputError(f"{path}: the file can't be read: {reason.strerror}") from reason
    raise InputError(
        f"{path}: the file can't be read: it is not {'UTF-16' if is_utf_16 else 'UTF-8'} text"
    )


def _table_in_lines(
    request: _Request, read_lines: Callable[[], Iterator[Line]], encoding_in_words: str
) -> TextTable:
    """Read a text table: its layout from the first lines of the file, then all its rows.

    Parameters
    ----------
    request
        file, quantities to be read (empty: every column), and `kind` of table; some kinds may lack
        headings
    read_lines
        yields number and text of the lines, from the first one on at each call
    encoding_in_words
        character encoding of the file, as stated to the user

    Raises
    ------
    InputError
        One sentence on the first line that does not fit.
    """
    # The first 200 lines show the layout: separator, headings, units, and where the rows begin.
    first_lines = list(islice(read_lines(), _MOST_LINES_LOOKED_AT))
    layout = None
    # A kind of table that may stand without headings is first taken for bare rows of numbers.
    if request.kind.may_lack_headings and not request.quantities:
        layout = _layout_of_bare_rows(first_lines)
    if layout is None:
        layout = _layout_of_table(request, first_lines)

    # Then all rows: their numbers, and the lines that are no rows.
    has_decimal_comma = layout.separator != "," and _has_decimal_comma(read_lines(), layout)
    rows = _read_rows(request, read_lines, layout, has_decimal_comma)
    # `columns_read`: indices (from 0) of the columns that are read.
    headings = tuple(layout.headings[k] for k in layout.columns_read)
    if not layout.heading_line_number:
        headings = tuple(f"column {k + 1}" for k in layout.columns_read)
    # SEPARATORS_IN_WORDS: name of each separator
    # `n_lines_above`: how many lines stand above the headings.
    return TextTable(
        names=request.quantities or headings,
        values=rows.values,
        line_numbers=rows.line_numbers,
        headings=headings,
        units=tuple(layout.units[k] for k in layout.columns_read),
        separator=SEPARATORS_IN_WORDS[layout.separator],
        decimal_sign="comma" if has_decimal_comma else "point",
        encoding=encoding_in_words,
        heading_line_number=layout.heading_line_number,
        n_lines_above=layout.n_lines_above,
        unread_headings=_headings_of_unread_columns(layout),
        lines_left_out=(*_skipped_lines_in_words(layout), *rows.lines_left_out),
        first_clock_text=rows.first_clock_text,
    )


def _encodings_of(first_bytes: bytes) -> list[str]:
    """Character encodings, likeliest first, that a text file with these `first_bytes` may have.

    UTF-16 has a byte-order mark at its start, or more than 80 % zeros among its bytes of odd or of
    even number. Other bytes with zeros are tried as UTF-8 alone.

    >>> _encodings_of("Zeit;P".encode("utf-16-le")), _encodings_of(b"time,P")
    (['utf-16-le'], ['utf-8-sig', 'cp1252', 'cp932', 'latin-1'])
    """
    # _BYTE_ORDER_MARKS_OF_UTF_16: FF FE and FE FF
    if first_bytes.startswith(_BYTE_ORDER_MARKS_OF_UTF_16):
        return ["utf-16"]
    if b"\0" not in first_bytes:
        return ["utf-8-sig", "cp1252", "cp932", "latin-1"]
    n_pairs_of_bytes = max(len(first_bytes) // 2, 1)
    # _LEAST_ZERO_SHARE_OF_UTF_16: 0.8 of every second byte
    if first_bytes[1::2].count(0) > _LEAST_ZERO_SHARE_OF_UTF_16 * n_pairs_of_bytes:
        return ["utf-16-le"]
    if first_bytes[0::2].count(0) > _LEAST_ZERO_SHARE_OF_UTF_16 * n_pairs_of_bytes:
        return ["utf-16-be"]
    return ["utf-8-sig"]


def _headings_of_unread_columns(layout: _Layout) -> tuple[str, ...]:
    """Headings of the columns that are not read."""
    if not layout.heading_line_number:
        return ()
    return tuple(
        name
        for number, name in enumerate(layout.headings)
        if name and number not in layout.columns_read
    )


def _skipped_lines_in_words(layout: _Layout) -> list[str]:
    """The lines between headings and rows that are left out."""
    if not layout.numbers_of_lines_between:
        return []
    lines = ", ".join(map(str, layout.numbers_of_lines_between[:5]))
    return [f"line {lines}, between the headings and the rows: no numbers"]


def _numbered_lines(path: Path, stream: TextIO, most_characters: int) -> Iterator[Line]:
    """Yield number (from 1) and text of every line that is not empty, from the first line of an
    open file on; InputError for a line of more than `most_characters` characters.

    `path` is that of the file, for the message; `stream` is the open file.
    """
    stream.seek(0)
    for line_number, line in enumerate(iter(partial(stream.readline, most_characters + 1), ""), 1):
        if len(line) > most_characters:
            raise InputError(
                f"{path}, line {line_number}: more than {most_characters:,} characters are no row"
                " of a table"
            )
        if line.strip():
            yield line_number, line.strip(" \r\n")


def _cells_of_line(text: str, separator: str | None) -> list[str]:
    """The cells of a line; empty ones at its end are none. A separator within quotes is none."""
    texts = text.split(separator)
    if '"' in text and separator is not None:
        with contextlib.suppress(csv.Error, StopIteration):
            texts = next(csv.reader([text], delimiter=separator, skipinitialspace=True))
    cells = [cell.strip().strip('"').strip() for cell in texts]
    while len(cells) > 1 and not cells[-1]:
        del cells[-1]
    return cells


def _number_in_cell(text: str, has_decimal_comma: bool) -> float | None:
    """The number in a cell; None where it is none with this decimal sign."""
    if "_" in text or (has_decimal_comma and "." in text):
        return None
    text_with_point = text.replace(",", ".") if has_decimal_comma else text
    try:
        return float(text_with_point)
    except ValueError:
        return None


def _is_numeric(text: str, separator: str | None) -> bool:
    """Whether every cell is a number, with or without marks between thousands, or a time of day."""
    return all(
        _is_number_or_time(cell, separator) or _GROUPED_DIGITS.match(cell)
        for cell in _cells_of_line(text, separator)
    )


def _possible_headings(text: str, separator: str | None) -> list[list[str]]:
    """Cells of a line of headings, one list for each way to cut it that gives other cells.

    Where blanks separate the cells, a heading may also hold single blanks.
    """
    cells = _cells_of_line(text, separator)
    if separator is not None:
        return [cells]
    cells_with_blanks = [cell.strip('"') for cell in re.split(r"\s{2,}|\t", text)]
    return [cells] if cells_with_blanks == cells else [cells_with_blanks, cells]


def _layout_of_bare_rows(lines: list[Line]) -> _Layout | None:
    """Layout of a text table without headings whose first line is a row of two numbers or more;
    None for any other first line. The columns are named "column 1" and so on.

    `lines` are (line number, text) of the first lines of the file. Comments among them are skipped.
    """
    # _COMMENT_MARKS: beginnings of comments: #, **, % and //
    lines_without_comments = [
        (number, text) for number, text in lines if not text.startswith(_COMMENT_MARKS)
    ]
    if not lines_without_comments:
        return None
    line_number, text = lines_without_comments[0]
    # Tab, semicolon, comma, and None for blanks.
    for separator in SEPARATORS_IN_WORDS:
        cells = _cells_of_line(text, separator)
        n_columns = len(cells)
        if n_columns > 1 and _is_numeric(text, separator):
            return _Layout(
                separator=separator,
                headings=tuple(f"column {k + 1}" for k in range(n_columns)),
                units=("",) * n_columns,
                columns_read=tuple(range(n_columns)),
                heading_line_number=0,
                first_row_line_number=line_number,
                n_lines_above=0,
            )
    return None


def _layout_of_table(request: _Request, lines: list[Line]) -> _Layout:
    """Separator of a text table, and where its headings, units and rows stand, from the first
    `lines` (number, text) of its file.

    The line of headings stands above the rows. It is the first that has the headings of all
    quantities to be read, and a first row to go with them. Where every column is read it is the
    first line with two headings that this kind of table expects. Without such a line it is the
    first of two words or more. A table of rows alone may take its columns by their order or number.

    Parameters
    ----------
    request
        `path` of the file, and `quantities` to be read; empty for every column

    Raises
    ------
    InputError
        For a file that has no such table.
    """
    path = request.path
    quantities = request.quantities
    # _COMMENT_MARKS: beginnings of comments: #, **, % and //
    lines_without_comments = [line for line in lines if not line[1].startswith(_COMMENT_MARKS)]
    needed_text = "a line of names and rows of numbers"
    if quantities:
        needed_text = f"{len(quantities)} columns {', '.join(quantities)}"
    if not lines_without_comments:
        raise InputError(f"{path}: the file is empty; {needed_text} are needed")
    _, first_text = lines_without_comments[0]
    # _MARKUP_START: pattern of the beginning of JSON, XML or HTML
    if _MARKUP_START.match(first_text):
        raise InputError(
            f"{path}: this is JSON, XML or HTML and no table: write {needed_text}, separated"
            " by commas"
        )
    # Where every column is read: first a line with two expected headings, then any.
    for fewest_expected_headings in (0,) if quantities else (2, 0):
        layouts_without_fit: list[_Layout] = []
        for index, (_, text) in enumerate(lines):
            if _is_row(text, max(len(quantities), 1)):
                break
            # Layouts with these headings, for each way to cut the line.
            for layout, first_row_fits in _layouts_with_headings_at(
                request, lines, index, fewest_expected_headings
            ):
                if first_row_fits:
                    return layout
                layouts_without_fit.append(layout)
        # No headings fit their first row. The first ones cut by the separator of the rows count all
        # the same: that row is reported later as one at fault. Without any row of numbers there is
        # no separator to compare with.
        fewest_cells = max(len(quantities), 2)
        # Index, separator and cells of the first row of numbers.
        _, separator_of_rows, cells_of_row = _first_numeric_row(
            lines_without_comments, fewest_cells
        )
        has_numeric_row = bool(cells_of_row)
        for layout in layouts_without_fit:
            if not has_numeric_row or layout.separator == separator_of_rows:
                return layout

    return _layout_without_headings(request, lines_without_comments)


def _is_row(text: str, fewest_cells: int) -> bool:
    """Whether a line is a row of numbers by any separator, and no comment."""
    return not text.startswith(_COMMENT_MARKS) and any(
        len(_cells_of_line(text, separator)) >= fewest_cells and _is_numeric(text, separator)
        for separator in SEPARATORS_IN_WORDS
    )


def _layouts_with_headings_at(
    request: _Request, lines: list[Line], index: int, fewest_expected_headings: int
) -> Iterator[tuple[_Layout, bool]]:
    """Layouts of a text table if `lines[index]` holds its headings, one for each separator and each
    way to cut that line by it. Each comes with a boolean: True where its first row fits, or where
    it has no rows.

    A row fits if it has a cell for every heading, and a number in a column that is read. A comment
    holds the headings only above a row of numbers that fits.

    Parameters
    ----------
    request
        file; `quantities` to be read (empty: every column); `kind` of table, with the headings to
        expect; whether the user takes all columns by number
    lines
        (line number, text) of the first lines of the file
    index
        of the line that may hold the headings
    fewest_expected_headings
        where every column is read: how many of the line's headings must be expected ones
    """
    line_number, text = lines[index]
    # _COMMENT_MARKS: beginnings of comments: #, **, % and //
    is_comment = text.startswith(_COMMENT_MARKS)
    heading_text = text.lstrip("#*%/ ") if is_comment else text
    # Whether lines without numbers may stand between headings and rows: not below any two words.
    may_skip_lines = bool(request.quantities) or fewest_expected_headings > 0
    # SEPARATORS_IN_WORDS: tab, semicolon, comma, and None for blanks
    for separator in SEPARATORS_IN_WORDS:
        for headings in _possible_headings(heading_text, separator):
            # Indices (from 0) of the columns that are read; None where these are no headings.
            if request.quantities:
                columns_read = _columns_of_quantities(request, line_number, headings)
            else:
                columns_read = _columns_if_expected(
                    request, headings, is_comment, fewest_expected_headings
                )
            # Columns that are stated by number need no headings: `_layout_without_headings` finds
            # their rows.
            if columns_read is None or request.takes_columns_by_number:
                continue

            # The layout with these headings, and the text of its first row.
            layout, text_of_first_row = _layout_with_headings(
                request,
                lines,
                index,
                separator,
                _NamedColumns(headings, columns_read),
                may_skip_lines,
            )

            first_row_fits = text_of_first_row is None or (
                _has_cell_for_each_heading(
                    text_of_first_row, separator, columns_read, len(headings)
                )
                and _has_number(text_of_first_row, separator, columns_read)
            )
            if is_comment and (
                text_of_first_row is None
                or not first_row_fits
                or not _is_numeric(text_of_first_row, separator)
            ):
                continue
            yield layout, first_row_fits


def _columns_if_expected(
    request: _Request, headings: Sequence[str], is_comment: bool, fewest_expected_headings: int
) -> tuple[int, ...] | None:
    """Indices (from 0) of all columns of a text table of which every column is read; None where the
    words of a line are not taken for headings.

    They are taken for headings if they are two or more, not in a comment, and if at least
    `fewest_expected_headings` of them are ones that this kind of table (`request.kind`) expects.
    """
    n_expected_headings = sum(map(request.kind.is_expected_heading, headings))
    if is_comment or len(headings) < 2 or n_expected_headings < fewest_expected_headings:
        return None
    return tuple(range(len(headings)))


class _NamedColumns(NamedTuple):
    """Headings of all columns of a table, and indices (from 0) of those that are read."""

    headings: list[str]
    columns_read: tuple[int, ...]


def _layout_with_headings(
    request: _Request,
    lines: list[Line],
    index: int,
    separator: str | None,
    columns: _NamedColumns,
    may_skip_lines: bool,
) -> tuple[_Layout, str | None]:
    """Layout of a text table whose headings stand in `lines[index]`, cut by `separator`; and the
    text of its first row, None for a table without rows.

    The unit of a column is that of a line of units below the headings, else that within its
    heading, else that of a line of units above.

    Parameters
    ----------
    request
        file, and quantities to be read
    lines
        (line number, text) of the first lines of the file
    separator
        between cells; None for blanks
    columns
        `headings` of all columns; `columns_read`: indices (from 0) of those that are read
    may_skip_lines
        whether lines without numbers may stand between headings and rows
    """
    heading_line_number, _ = lines[index]
    # _COMMENT_MARKS: beginnings of comments: #, **, % and //
    lines_below = [
        (line_number, text)
        for line_number, text in lines[index + 1 :]
        if not text.startswith(_COMMENT_MARKS)
    ]
    lines_above = [
        (line_number, text)
        for line_number, text in lines[:index]
        if not text.startswith(_COMMENT_MARKS)
    ]
    # Units of the columns by lines above and below, "" where none; `rows`: (line number, text) of
    # the lines from the first row on.
    units_above = _labelled_units(lines_above, separator, len(columns.headings))
    units_below, numbers_of_lines_between, rows = _lines_below_headings(
        lines_below, separator, columns, may_skip_lines
    )

    # Below, in the heading, or above: `unit_in` gives heading and unit apart.
    units = [
        unit_below or unit_in(heading)[1] or unit_above
        for unit_below, heading, unit_above in zip(
            units_below, columns.headings, units_above, strict=True
        )
    ]

    first_row_line_number = heading_line_number + 1
    text_of_first_row = None
    if rows:
        first_row_line_number, text_of_first_row = rows[0]
    layout = _Layout(
        separator=separator,
        headings=tuple(columns.headings),
        units=tuple(units),
        columns_read=columns.columns_read,
        heading_line_number=heading_line_number,
        first_row_line_number=first_row_line_number,
        n_lines_above=len(lines_above),
        numbers_of_lines_between=numbers_of_lines_between,
        time_column=_time_column(request, columns.headings, columns.columns_read),
    )
    return layout, text_of_first_row


class _LinesBelowHeadings(NamedTuple):
    """What stands below the headings of a text table.

    Attributes
    ----------
    units
        (n_columns,) by a line of units; each an empty text without such a line
    skipped_lines
        numbers of the lines before the first row that hold neither units nor numbers
    rows
        (line number, text) of the lines from the first row on
    """

    units: list[str]
    skipped_lines: tuple[int, ...]
    rows: list[Line]


def _lines_below_headings(
    lines: list[Line], separator: str | None, columns: _NamedColumns, may_skip_lines: bool
) -> _LinesBelowHeadings:
    """Line of units, where there is one, and first row of numbers among the `lines` below the
    headings of a text table.

    Parameters
    ----------
    lines
        (line number, text) below the headings, without comments
    separator
        between cells; None for blanks
    columns
        `headings` of all columns; `columns_read`: indices (from 0) of those that are read,
        in one of which a row has a number
    may_skip_lines
        whether lines that hold neither units nor numbers may stand before the first row

    Returns
    -------
    _LinesBelowHeadings
        Units of the columns, "" where none; numbers of the lines skipped; the lines from the first
        row on.
    """
    n_columns = len(columns.headings)
    units = [""] * n_columns
    numbers_of_skipped_lines: list[int] = []
    for index, (line_number, text) in enumerate(lines):
        cells = _cells_of_line(text, separator)
        if _has_number(text, separator, columns.columns_read):
            return _LinesBelowHeadings(units, tuple(numbers_of_skipped_lines), lines[index:])
        # Units without brackets; a dash is no unit.
        unit_cells = [cell.strip("[](){}<> ").strip("-") for cell in cells]
        has_cell_for_headings = len(cells) == n_columns or (
            separator is not None and len(cells) < n_columns
        )
        if has_cell_for_headings and not any(units) and _are_units(cells):
            units = unit_cells + [""] * (n_columns - len(cells))
        elif may_skip_lines:
            numbers_of_skipped_lines.append(line_number)
        else:
            return _LinesBelowHeadings(units, (), lines[index:])
    # No row of numbers: the lines below are reported as rows at fault.
    return _LinesBelowHeadings([""] * n_columns, (), lines)


def _labelled_units(lines: list[Line], separator: str | None, n_columns: int) -> list[str]:
    """Units (n_columns,) of the columns from a line above the rows whose first cell has the word
    "units", as oscilloscopes and LabVIEW write it; empty texts without such a line. `lines` are
    (line number, text).

    The line holds a unit for each column but the first. Or it begins with the raw unit of an
    instrument, such as volts, which then is that of all columns.

    >>> _labelled_units([(1, "Horizontal Units,s"), (2, "Vertical Units,V,V")], ",", 3)
    ['', 'V', 'V']
    >>> _labelled_units([(1, "Vertical Units,V,,-1.0,5.1,Vertical Units,V,,-1.0,0.2")], ",", 2)
    ['V', 'V']
    """
    # `_RAW_UNITS`: units of an instrument's raw signal, such as volts or counts.
    units = [""] * n_columns
    most_cells_of_units = 0
    for _, text in lines:
        label, *cells = _cells_of_line(text, separator)
        # _WORDS_FOR_UNITS: pattern of "units" in several languages
        if not _WORDS_FOR_UNITS.search(normalised_name(label).lower()) or not cells:
            continue
        has_numbers = any(_is_number_or_time(cell, separator) for cell in cells)
        # Of several lines of units the one with most cells is taken.
        is_line_of_units = most_cells_of_units < len(cells) < n_columns and _are_units(cells)
        if is_line_of_units and not has_numbers:
            most_cells_of_units = len(cells)
            units[1:] = cells + [""] * (n_columns - 1 - most_cells_of_units)
        elif not most_cells_of_units and cells[0].lower() in _RAW_UNITS:
            units = [cells[0]] * n_columns
    return units


def _are_units(cells: Sequence[str]) -> bool:
    """Whether the cells of a line in a text table are units: all stand in brackets, or at least one
    is a known unit or a raw unit of an instrument, such as volts.

    >>> _are_units(["s", "kN", "-"]), _are_units(["(s)", "(V)"]), _are_units(["a", "b"])
    (True, True, False)
    """
    words = [cell.strip("[](){}<> ") for cell in cells]
    full_cells = [cell for cell in cells if cell]
    if full_cells and all(cell[0] in "[({<" and cell[-1] in "])}>" for cell in full_cells):
        return True
    # _RAW_UNITS: V, mV, counts and the like
    return any(is_unit(word) or word.lower() in _RAW_UNITS for word in words)


def _is_number_or_time(cell: str, separator: str | None) -> bool:
    """Whether a cell is a number, with either decimal sign, or a time of day."""
    return _number_in_cell(cell, separator != "," and "," in cell) is not None or is_clock_time(
        cell
    )


def _has_cell_for_each_heading(
    row: str, separator: str | None, columns_read: Sequence[int], n_headings: int
) -> bool:
    """Whether a row has a cell for each of `n_headings` headings. Where the separator is no blank,
    the last cells may be left out, but for those of the columns that are read.
    """
    n_cells = len(_cells_of_line(row, separator))
    if separator is None:
        return n_cells == n_headings
    return max(columns_read) < n_cells <= n_headings


def _has_number(row: str, separator: str | None, columns_read: Sequence[int]) -> bool:
    """Whether a column that is read holds a number in this row: the separator is right."""
    cells = _cells_of_line(row, separator)
    return any(_is_number_or_time(cells[k], separator) for k in columns_read if k < len(cells))


def _time_column(
    request: _Request, headings: Sequence[str], columns_read: tuple[int, ...]
) -> int | None:
    """Index (from 0) of the column of time, which may hold times of day; None without one.

    Where quantities are to be read, it is the column of "time", if that is one of them. Where every
    column is read, it is the first whose heading is a usual one of time. `columns_read` are the
    indices of the quantities' columns, in their order.
    """
    if "time" in request.quantities:
        return columns_read[request.quantities.index("time")]
    if request.quantities:
        return None
    # ALIASES: usual headings of each quantity
    names_of_time = {normalised_name(alias) for alias in ALIASES["time"]}
    return next(
        (k for k, heading in enumerate(headings) if normalised_name(heading) in names_of_time), None
    )


def _columns_of_quantities(
    request: _Request, line_number: int, headings: Sequence[str]
) -> tuple[int, ...] | None:
    """Index (from 0) of the column of each quantity to be read, by the headings of a line; None
    where a quantity has no column here, or two would have the same.

    Parameters
    ----------
    request
        `path` of the file; `quantities`, such as "time"; `stated_columns`: heading or number of the
        column of a quantity, where the user states it
    line_number
        of the headings, for the message

    Raises
    ------
    InputError
        Where several headings could be that of one quantity.
    """
    # Indices (from 0) of the columns that may hold each quantity.
    candidates_of_quantities = [
        _candidate_columns(quantity, request.stated_columns.get(quantity), headings)
        for quantity in request.quantities
    ]
    if not all(candidates_of_quantities):
        return None
    columns_read: list[int] = []
    for quantity, candidates in zip(request.quantities, candidates_of_quantities, strict=True):
        if len(candidates) > 1:
            candidate_headings = ", ".join(repr(headings[k]) for k in candidates)
            raise InputError(
                f"{request.path}, line {line_number}: {candidate_headings} could each be"
                f" {quantity}; say which by columns = {{{quantity} = ...}}"
            )
        columns_read += candidates
    return tuple(columns_read) if len(set(columns_read)) == len(columns_read) else None


def _candidate_columns(
    quantity: str, stated_column: str | int | None, headings: Sequence[str]
) -> list[int]:
    """Indices (from 0) of the columns that may hold a quantity, such as "time", by their headings.

    Where the user states a heading or a column number (from 1) as `stated_column`, that one alone;
    none where it does not exist. Else the columns under the first of the quantity's usual headings
    that occurs here. Capitals and units within headings do not count.
    """
    if isinstance(stated_column, int):
        return [stated_column - 1] if stated_column <= len(headings) else []
    if stated_column is not None:
        stated_heading = stated_column.strip()
        return [
            k
            for k, heading in enumerate(headings)
            if stated_heading in (heading, unit_in(heading)[0])
        ]

    # `unit_in` gives heading and unit apart; `normalised_name` a common spelling.
    spellings_of_headings = []  # for each heading, with and without its unit
    for heading in headings:
        texts = (heading, unit_in(heading)[0], name_without_unit(heading))
        spellings_of_headings.append({normalised_name(text).lower() for text in texts})

    # Usual headings of the quantity, likeliest first.
    for alias in aliases_of(quantity):
        columns_of_alias = [
            k
            for k, spellings in enumerate(spellings_of_headings)
            if normalised_name(alias).lower() in spellings
        ]
        if columns_of_alias:
            return columns_of_alias
    return []


def _layout_without_headings(request: _Request, lines: list[Line]) -> _Layout:
    """Layout of a text table in which no line of headings was recognised: rows of numbers with one
    cell for each quantity to be read, or columns that the user states by number.

    Parameters
    ----------
    request
        file; `quantities` to be read, empty for every column; `stated_columns`: heading or number
        (from 1) of the column of a quantity, where the user states it
    lines
        (line number, text) of the first lines of the file, without comments

    Raises
    ------
    InputError
        For a file that is no such table: what is wrong with it, and what to do.
    """
    quantities = request.quantities
    _, first_text = lines[0]
    # SEPARATORS_IN_WORDS: tab, semicolon, comma, and None for blanks
    begins_with_rows = any(
        len(_cells_of_line(first_text, separator)) > 1 and _is_numeric(first_text, separator)
        for separator in SEPARATORS_IN_WORDS
    )
    if not quantities:
        raise _fault_of_no_names(request, lines[0], begins_with_rows)

    # The first row of numbers: its index among the lines, its separator and its cells.
    first_row = _first_numeric_row(lines, len(quantities))
    if request.takes_columns_by_number:
        indices_by_user = [int(request.stated_columns[name]) - 1 for name in quantities]
        # Other cells of the row may hold text.
        first_row = _first_row_with_numbers(lines, indices_by_user) or first_row

    row_index, _, cells_of_row = first_row
    # Rows alone, in the order of the quantities, with no heading stated.
    has_cell_for_each_quantity = (
        row_index == 0
        and len(cells_of_row) == len(quantities)
        and not any(isinstance(heading, str) for heading in request.stated_columns.values())
    )
    if cells_of_row and (request.takes_columns_by_number or has_cell_for_each_quantity):
        return _layout_of_rows(request, lines, first_row)
    if begins_with_rows:
        raise _fault_of_count(request, lines[0], len(cells_of_row))
    raise _fault_of_headings(request, lines)


def _columns_by_number_or_order(
    request: _Request, n_columns: int, first_row_line_number: int
) -> tuple[int, ...]:
    """Indices (from 0) of the columns of a text table that are read: those that the user states by
    number, where `takes_columns_by_number`, else the first ones, in the order of the quantities.

    InputError for a column beyond the `n_columns` of the first row, whose line in the file has the
    number `first_row_line_number`.
    """
    columns_read = tuple(range(len(request.quantities)))
    if request.takes_columns_by_number:
        columns_read = tuple(int(request.stated_columns[name]) - 1 for name in request.quantities)
    if max(columns_read) >= n_columns:
        raise InputError(
            f"{request.path}, line {first_row_line_number}: there is no column"
            f" {max(columns_read) + 1}: the line has {n_columns}"
        )
    return columns_read


def _layout_of_rows(request: _Request, lines: list[Line], first_row: FirstRow) -> _Layout:
    """Layout of a text table from its first row on. The columns are those that the user states by
    number, or stand in the order of the quantities to be read.

    Headings and units are taken from lines above the row, where there are any.

    Parameters
    ----------
    request
        file; `quantities` to be read; `stated_columns`: number (from 1) of each one's column, where
        `takes_columns_by_number`
    lines
        (line number, text) of the first lines of the file, without comments
    first_row
        index of the first row among the lines, its separator, and its cells

    Raises
    ------
    InputError
        For a column number beyond the cells of the row.
    """
    row_index, separator, cells_of_row = first_row
    first_row_line_number, _ = lines[row_index]
    n_columns = len(cells_of_row)
    columns_read = _columns_by_number_or_order(request, n_columns, first_row_line_number)

    # A column is named by its quantity; others "column 3" and so on.
    quantity_of_column = dict(zip(columns_read, request.quantities, strict=True))
    column_names = [quantity_of_column.get(k, f"column {k + 1}") for k in range(n_columns)]

    # Headings and units above the row: line number 0 and nothing where there are none.
    heading_line_number, headings, units_above = _headings_above_rows(
        lines[:row_index], separator, n_columns
    )
    labelled_units = _labelled_units(lines, separator, n_columns)
    units = tuple(
        unit_above or labelled_unit
        for unit_above, labelled_unit in zip(
            units_above or ("",) * n_columns, labelled_units, strict=True
        )
    )
    n_lines_above = row_index
    if heading_line_number:
        n_lines_above = sum(line_number < heading_line_number for line_number, _ in lines)
    return _Layout(
        separator=separator,
        headings=headings or tuple(column_names),
        units=units,
        columns_read=columns_read,
        heading_line_number=heading_line_number,
        first_row_line_number=first_row_line_number,
        n_lines_above=n_lines_above,
        time_column=_time_column(request, column_names, columns_read),
    )


def _fault_of_no_names(request: _Request, first_line: Line, begins_with_rows: bool) -> InputError:
    """Error for a text table of which every column is to be read and that has no headings: its
    first line must name the columns.

    Parameters
    ----------
    request
        `path` of the file; `kind` of table, with an example of its headings and the keys that take
        columns by number
    first_line
        its number and text
    begins_with_rows
        whether it is a row of numbers
    """
    line_number, text = first_line
    fault_text = f"it is {shortened_repr(text)}"
    if begins_with_rows or _is_numeric(text, None):
        fault_text = "it has numbers only"
    advice = ""
    if request.kind.keys_by_number and begins_with_rows:
        advice = f"; or take them by number: {request.kind.keys_by_number}"
    return InputError(
        f"{request.path}, line {line_number}: the first line must name the columns, such as"
        f" {request.kind.example}; {fault_text}{advice}"
    )


def _fault_of_count(request: _Request, first_line: Line, n_cells: int) -> InputError:
    """Error for a text table of numbers alone whose rows have more or fewer cells, `n_cells`, than
    there are quantities to be read.

    `request` holds the path of the file and the quantities; `first_line` is its number and text,
    for the message.
    """
    line_number, text = first_line
    quantities = request.quantities
    advice = ""
    if n_cells == 2 * len(quantities):
        advice = "; semicolons between the columns where commas stand in the numbers"
    numbered_quantities = ", ".join(f"{name} = {k}" for k, name in enumerate(quantities, 1))
    return InputError(
        f"{request.path}, line {line_number}: {len(quantities)} numbers"
        f" ({', '.join(quantities)}) are needed, not {shortened_repr(text)}{advice}; or say which"
        " by"
        f" columns = {{{numbered_quantities}}}"
    )


def _fault_of_headings(request: _Request, lines: list[Line]) -> InputError:
    """Error for a text table without headings for all quantities to be read: which quantities have
    none, and how the user states their columns.

    `lines` are (line number, text) of the first ones of the file. `request.stated_columns` holds
    the heading or number of a quantity's column where the user states it.
    """
    quantities = request.quantities
    list_of_quantities = ", ".join(quantities)
    # The line that most probably holds the headings, and these headings.
    (line_number, text), headings = _likeliest_heading_line(request, lines)
    lacking_quantities = [name for name in quantities if not _has_column(request, name, headings)]
    if not lacking_quantities and len(headings) >= len(quantities):
        return InputError(
            f"{request.path}, line {line_number}: columns: {list_of_quantities} must be of"
            f" different columns of {shortened_repr(text)}"
        )
    # Each quantity has a heading, but there are fewer headings than quantities: name them all.
    quantities_to_state = lacking_quantities or quantities
    stated_headings = [
        shortened_repr(request.stated_columns[name])
        for name in lacking_quantities
        if name in request.stated_columns
    ]
    reason = f"none is known as {' or '.join(quantities_to_state)}"
    if stated_headings:
        reason = f"no heading is {' or '.join(stated_headings)}"
    return MissingColumnError(
        quantities_to_state,
        headings,
        f"{request.path}, line {line_number}: the columns are {list_of_quantities}, not"
        f" {shortened_repr(text)}: {reason}; say which by columns ="
        f" {{{quantities_to_state[0]} = ...}}, by"
        " its heading or its number from 1 on",
    )


def _has_column(request: _Request, quantity: str, headings: Sequence[str]) -> bool:
    """Whether one of the headings is that of a quantity to be read."""
    return bool(_candidate_columns(quantity, request.stated_columns.get(quantity), headings))


def _likeliest_heading_line(request: _Request, lines: list[Line]) -> tuple[Line, list[str]]:
    """The line of a text table that most probably holds its headings, and these headings; for the
    message on quantities without a column.

    It is the line above the rows with headings for most of the quantities. Where no line has one,
    it is the line above the first row of numbers, or above its units, else the first line. `lines`
    are (number, text) of the first ones of the file; `request` holds the quantities to be read.
    """
    # The first row of numbers with a cell for each quantity, else with fewer: index, separator,
    # cells.
    for fewest_cells in (len(request.quantities), 2, 1):
        row_index, separator_of_rows, cells_of_row = _first_numeric_row(lines, fewest_cells)
        if cells_of_row:
            break
    # SEPARATORS_IN_WORDS: tab, semicolon, comma, and None for blanks
    separators = (separator_of_rows,) if cells_of_row else tuple(SEPARATORS_IN_WORDS)

    # The line above that row, or above its units, cut in the way that gives most cells.
    likeliest_line = lines[max(row_index - 1, 0)]
    if row_index > 1 and _are_units(_cells_of_line(likeliest_line[1], separator_of_rows)):
        likeliest_line = lines[row_index - 2]
    likeliest_headings = max(
        (
            headings
            for separator in separators
            for headings in _possible_headings(likeliest_line[1], separator)
        ),
        key=len,
    )

    # Unless a line has headings of quantities: then the one with most of them.
    most_columns = 0
    for line in lines[:row_index]:
        for separator in separators:
            for headings in _possible_headings(line[1], separator):
                n_columns = sum(
                    _has_column(request, quantity, headings) for quantity in request.quantities
                )
                if n_columns > most_columns:
                    most_columns = n_columns
                    likeliest_line = line
                    likeliest_headings = headings
    return likeliest_line, likeliest_headings


def _first_numeric_row(lines: list[Line], fewest_cells: int) -> FirstRow:
    """The first line that is a row of `fewest_cells` numbers or more by any separator: its index,
    separator and cells; 0, None and no cells where there is none.

    `lines` are (line number, text).
    """
    for k, (_, text) in enumerate(lines):
        # SEPARATORS_IN_WORDS: tab, semicolon, comma, and None for blanks
        for separator in SEPARATORS_IN_WORDS:
            cells = _cells_of_line(text, separator)
            if _is_numeric(text, separator) and len(cells) >= fewest_cells:
                return k, separator, cells
    return 0, None, []


def _first_row_with_numbers(lines: list[Line], columns: Sequence[int]) -> FirstRow | None:
    """The first line with numbers in the given columns (from 0), whatever its other cells hold: its
    index, separator and cells; None where there is none. The line after it must have them too.

    `lines` are (line number, text).

    >>> rows = [(1, "Model,7,,0.0,5.1"), (2, "Source,CH1,,0.1,5.2"), (3, ",,,0.2,5.3")]
    >>> _first_row_with_numbers(rows, [3, 4])
    (0, ',', ['Model', '7', '', '0.0', '5.1'])
    """

    def has_numbers(text: str, separator: str | None) -> bool:
        """Whether the line has numbers in all these columns."""
        cells = _cells_of_line(text, separator)
        return max(columns) < len(cells) and all(
            _is_number_or_time(cells[column], separator) for column in columns
        )

    # SEPARATORS_IN_WORDS: tab, semicolon, comma, and None for blanks
    for separator in SEPARATORS_IN_WORDS:
        for index, (row, next_row) in enumerate(pairwise([text for _, text in lines])):
            if has_numbers(row, separator) and has_numbers(next_row, separator):
                return index, separator, _cells_of_line(row, separator)
    return None


def _headings_above_rows(
    lines: list[Line], separator: str | None, n_columns: int
) -> tuple[int, tuple[str, ...], tuple[str, ...]]:
    """Headings that stand above the first row of a text table whose columns are taken by number.

    Of the lines with `n_columns` cells the last one holds the headings; if its cells are units, the
    one before does. `lines` are (line number, text) of those above the row, `separator` stands
    between cells (None for blanks).

    Returns
    -------
    heading_line_number
        number (from 1) of the line of headings; 0 where no line has so many cells, or where other
        lines stand between headings and row
    headings, units
        (n_columns,) each; empty where there is no line of headings
    """
    lines_with_all_cells = [
        (number, cells_of_line)
        for number, text in lines
        for cells_of_line in _possible_headings(text, separator)
        if len(cells_of_line) == n_columns
    ]
    units = [""] * n_columns
    if len(lines_with_all_cells) > 1:
        _, cells_of_last_line = lines_with_all_cells[-1]
        if _are_units(cells_of_last_line):
            units = [cell.strip("[](){}<> ") for cell in cells_of_last_line]
            lines_with_all_cells.pop()
    if not lines_with_all_cells:
        return 0, (), ()
    heading_line_number, headings = lines_with_all_cells[-1]
    last_line, _ = lines[-1]
    # One line may stand between: the line of units.
    if heading_line_number < last_line - 1:
        return 0, (), ()
    units_of_columns = [
        unit or unit_in(heading)[1] for unit, heading in zip(units, headings, strict=True)
    ]
    return heading_line_number, tuple(headings), tuple(units_of_columns)


def _has_decimal_comma(lines: Iterator[Line], layout: _Layout) -> bool:
    """Whether a comma is the decimal sign of a text table. It is decided by the first row with a
    comma or a point in a column that is read; times of day do not count.

    In a cell with both signs the later one is the decimal sign; the other stands between thousands.
    Where no row has either, the decimal sign is a point.

    Parameters
    ----------
    lines
        (line number, text) of all lines of the file
    layout
        `separator` between cells (None for blanks), line number of the first row, and indices (from
        0) of the columns that are read
    """
    for line_number, text in lines:
        if line_number < layout.first_row_line_number or not ("," in text or "." in text):
            continue
        cells = _cells_of_line(text, layout.separator)
        cells_read = [cells[k] for k in layout.columns_read if k < len(cells)]
        cells_read = [cell for cell in cells_read if not is_clock_time(cell)]
        has_point = any("." in cell for cell in cells_read)
        has_comma = any("," in cell for cell in cells_read)
        if has_comma and has_point:
            return any(0 <= cell.find(".") < cell.rfind(",") for cell in cells_read)
        if has_comma or has_point:
            return has_comma
    return False


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of a text table.

    Attributes
    ----------
    values
        (n_rows, n_columns) numbers in the columns that are read
    line_numbers
        (n_rows,) number (from 1) of the line of each row
    lines_left_out
        lines that are no rows, in words
    first_clock_text
        first cell of a column of times of day, empty where times are numbers
    """

    values: Array
    line_numbers: NDArray[np.int64]
    lines_left_out: tuple[str, ...] = ()
    first_clock_text: str = ""


@dataclass(eq=False)
class _RowReader:
    """Streams the rows of a text table, so that only their numbers take memory.

    Attributes
    ----------
    request
        file, quantities and kind of the table
    read_lines
        yields number and text of the lines, from the first one on at each call
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
        """Number and text of each row of the table, from its first one on, without comments.

        The attribute `line_numbers` then holds the line numbers of the rows. `read_lines` yields
        all lines of the file; `layout` holds the line number of the first row; `request` holds
        file, quantities and kind of table.

        Raises
        ------
        InputError
            For more than 2,000,000 rows.
        """
        # Where every column is read, as those of result files are, a # may belong to a cell.
        may_end_in_comment = bool(self.request.quantities)
        line_numbers = self.line_numbers
        first_row_line_number = self.layout.first_row_line_number
        del line_numbers[:]
        for line_number, text in self.read_lines():
            # _COMMENT_MARKS: beginnings of comments: #, **, % and //
            if line_number < first_row_line_number or text.startswith(_COMMENT_MARKS):
                continue
            # MOST_ROWS: 2,000,000 rows are read
            if len(line_numbers) == MOST_ROWS:
                raise InputError(
                    f"{self.request.path}: {self.request.kind.role_of_file} has more than"
                    f" {MOST_ROWS:,}"
                    f" rows, the most that are read; {self.request.kind.advice_on_size}"
                )
            line_numbers.append(line_number)
            if may_end_in_comment and "#" in text:
                yield line_number, text.split("#", 1)[0].rstrip()
            else:
                yield line_number, text

    def rows_for_loadtxt(self) -> Iterator[str]:
        """Text of each row for `numpy.loadtxt`, with a decimal point.

        Iteration ends with a bare ValueError at a row with too few or too many cells, or with a
        point in a table with decimal commas. The caller then reads the rows cell by cell, which
        reports the fault.

        `layout` holds the separator (None for blanks), the headings, and the indices (from 0) of
        the columns that are read.
        """
        # `has_decimal_comma`: the decimal sign of the file is a comma.
        separator = self.layout.separator
        has_decimal_comma = self.has_decimal_comma
        # Between separators that are no blanks, cells behind the last column read may be left out.
        most_separators = len(self.layout.headings) - 1
        fewest_separators = most_separators if separator is None else max(self.layout.columns_read)
        for _, text in self.lines():
            # Empty cells at the end of a line do not count.
            row = text if separator is None else text.rstrip(f"{separator} ")
            n_separators = len(row.split()) - 1 if separator is None else row.count(separator)
            has_possible_cell_count = fewest_separators <= n_separators <= most_separators
            if not has_possible_cell_count or (has_decimal_comma and "." in row):
                raise ValueError
            yield row.replace(",", ".") if has_decimal_comma else row


def _read_rows(
    request: _Request,
    read_lines: Callable[[], Iterator[Line]],
    layout: _Layout,
    has_decimal_comma: bool,
) -> _Rows:
    """Read the rows of numbers of a text table: all at once by numpy, else cell by cell, which
    takes longer but reads times of day and reports the first fault.

    Parameters
    ----------
    request
        file, quantities and kind of the table
    read_lines
        yields number and text of the lines, from the first one on at each call
    layout
        the separator, the `headings`, and the indices (from 0) of the columns that are read
    has_decimal_comma
        whether the decimal sign is a comma

    Raises
    ------
    InputError
        For a table without rows, and for the first row with a fault.
    """
    # Streams the rows: their number and text, or their text for numpy.
    reader = _RowReader(request, read_lines, layout, has_decimal_comma)
    if next(reader.lines(), None) is None:
        list_of_headings = ", ".join(layout.headings[k] for k in layout.columns_read[:6])
        rest_text = ", ..." if len(layout.columns_read) > 6 else ""
        raise InputError(
            f"{request.path}: no row of numbers below the names {list_of_headings}{rest_text}"
        )
    try:
        values = np.loadtxt(
            reader.rows_for_loadtxt(),
            delimiter=layout.separator,
            comments=None,
            ndmin=2,
            usecols=layout.columns_read,
        )
    except InputError:
        raise
    except ValueError:
        values = None
    # A cell that is nan or beyond the largest number is a fault too, which needs its line.
    # LARGEST_NUMBER: 1e100, the largest number that is read
    if values is not None and (np.abs(values) <= LARGEST_NUMBER).all():
        return _Rows(values, np.array(reader.line_numbers, dtype=np.int64))
    return _read_rows_cell_by_cell(request.path, reader.lines(), layout, has_decimal_comma)


def _read_rows_cell_by_cell(
    path: Path, lines: Iterator[Line], layout: _Layout, has_decimal_comma: bool
) -> _Rows:
    """Read the rows of a text table cell by cell; times of day become seconds since the first row.

    Lines of text behind the last row, and lines that repeat the headings, are left out and
    reported.

    Parameters
    ----------
    path
        of the file, for messages
    lines
        number and text of the lines from the first row on, some of which may be no rows
    layout
        the `headings`, the separator, and the indices (from 0) of the columns that are read
    has_decimal_comma
        whether the decimal sign is a comma

    Raises
    ------
    InputError
        For the first row with a fault: too few or too many cells, or a cell that is no number.
    """
    clock = ClockColumn()  # turns times of day into seconds, row after row
    values_of_rows = array("d")  # of all rows, one after the other
    line_numbers = array("q")
    text_since_last_row: list[Line] = []
    numbers_of_heading_lines: list[int] = []

    # Lines of text wait until a row follows: then they are at fault.
    for line_number, text in lines:
        cells = _cells_of_line(text, layout.separator)
        if cells == [name.strip() for name in layout.headings]:
            numbers_of_heading_lines.append(line_number)
            continue
        if _is_line_of_text(cells, layout, has_decimal_comma):
            text_since_last_row.append((line_number, text))
            continue
        if text_since_last_row:  # text between rows is at fault: reading it as a row raises
            _values_of_row(path, text_since_last_row[0], layout, has_decimal_comma, clock)
        values_of_rows.extend(
            _values_of_row(path, (line_number, text), layout, has_decimal_comma, clock)
        )
        line_numbers.append(line_number)
    if not line_numbers:  # a table of text alone: reading it as a row raises too
        _values_of_row(path, text_since_last_row[0], layout, has_decimal_comma, clock)
    return _Rows(
        np.array(values_of_rows).reshape(-1, len(layout.columns_read)),
        np.array(line_numbers, dtype=np.int64),
        _lines_left_out_in_words(numbers_of_heading_lines, text_since_last_row),
        clock.first_text,
    )


def _lines_left_out_in_words(
    numbers_of_heading_lines: Sequence[int], text_behind_rows: Sequence[Line]
) -> tuple[str, ...]:
    """What was left out of a text table, in words for the user; empty where nothing was.

    `numbers_of_heading_lines` are those of lines that repeat the headings; five are named at most.
    `text_behind_rows` are number and text of the lines behind the last row.
    """
    lines_left_out = []
    if numbers_of_heading_lines:
        numbers_in_words = ", ".join(map(str, numbers_of_heading_lines[:5]))
        lines_left_out.append(f"line {numbers_in_words}: the headings once more")
    if text_behind_rows:
        first_line_number, first_text = text_behind_rows[0]
        n_lines = len(text_behind_rows)
        count_in_words = "1 line" if n_lines == 1 else f"{n_lines} lines"
        lines_left_out.append(
            f"{count_in_words} behind the rows, from line {first_line_number} on:"
            f" {shortened_repr(first_text)}"
        )
    return tuple(lines_left_out)


def _is_line_of_text(cells: Sequence[str], layout: _Layout, has_decimal_comma: bool) -> bool:
    """Whether a line is text and no row: a word stands in the first column that is read."""
    column = layout.columns_read[0]
    first_cell = cells[column] if column < len(cells) else cells[0]
    return (
        first_cell[:1].isalpha()
        and _number_in_cell(first_cell, has_decimal_comma) is None
        and not is_clock_time(first_cell)
    )


def _values_of_row(
    path: Path, line: Line, layout: _Layout, has_decimal_comma: bool, clock: ClockColumn
) -> list[float]:
    """Numbers of one row of a text table in the columns that are read; a time of day as seconds
    since the first row.

    Parameters
    ----------
    path
        of the file, for messages
    line
        number and text of the row
    layout
        the `headings`, the separator (None for blanks), the indices (from 0) of the columns
        that are read, and that of the column that may hold times of day
    has_decimal_comma
        whether the decimal sign is a comma
    clock
        turns times of day into seconds, row after row

    Raises
    ------
    InputError
        For more or fewer cells than headings, or a cell that is no number of at most 1e100 in size.
    """
    line_number, row_text = line
    headings = layout.headings
    cells = _cells_of_line(row_text, layout.separator)

    # A cell for each heading; between separators that are no blanks the last may be left out.
    if not _has_cell_for_each_heading(
        row_text, layout.separator, layout.columns_read, len(headings)
    ):
        list_of_headings = ", ".join(headings[:6]) + (", ..." if len(headings) > 6 else "")
        advice = ""
        if layout.separator == "," and len(cells) > len(headings):
            advice = (
                "; commas between the columns leave points for the numbers, without marks between"
                " thousands"
            )
        raise InputError(
            f"{path}, line {line_number}: {len(headings)} numbers ({list_of_headings}) are needed,"
            f" not {shortened_repr(row_text)}{advice}"
        )

    # A number in each column that is read; a time of day counts in the column of time.
    row_values: list[float] = []
    for column in layout.columns_read:
        cell = cells[column]
        cell_value = _number_in_cell(cell, has_decimal_comma)
        reason_of_clock = ""
        if cell_value is None and column == layout.time_column:
            try:
                cell_value = clock.seconds(cell)
            except ValueError as reason:
                reason_of_clock = f": {reason}"
        # LARGEST_NUMBER: 1e100, the largest number that is read
        if cell_value is None or not abs(cell_value) <= LARGEST_NUMBER:
            advice = _advice_on_cell(
                cell, has_decimal_comma, column == layout.time_column, reason_of_clock
            )
            raise InputError(
                f"{path}, line {line_number}: {headings[column]} = {shortened_repr(cell)} is not a"
                " finite"
                f" number of at most {LARGEST_NUMBER:g}{advice}"
            )
        row_values.append(cell_value)
    return row_values


def _advice_on_cell(
    cell: str, has_decimal_comma: bool, is_in_time_column: bool, reason_of_clock: str
) -> str:
    """End of the message on a `cell` of a text table that is no number: what to do about it, or why
    it is no time either.

    `reason_of_clock` is the reason why a time in it is refused, "" where none is recognised;
    `has_decimal_comma`: the decimal sign of the file is a comma.
    """
    # _GROUPED_DIGITS: pattern of a number with marks between thousands
    if _GROUPED_DIGITS.match(cell):
        decimal_sign = "comma" if has_decimal_comma else "point"
        return (
            f"; the decimal sign of this file is a {decimal_sign}: write no marks between thousands"
        )
    if not cell:
        return ": fill it in, or take out the line"
    if is_in_time_column and not reason_of_clock:
        return f", nor a time such as {EXAMPLES_OF_CLOCK_TIMES}"
    return reason_of_clock
