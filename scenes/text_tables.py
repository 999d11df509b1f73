"""Text tables that other programs write, to columns of numbers: separator, decimal sign, headings,
units, the line of each fault.

A table is a line of headings, perhaps a line of units, then rows of numbers. The first lines show
which separator it has; the rows are streamed, so that two million of them take no more memory than
their numbers.
"""

from __future__ import annotations

import contextlib
import re
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from scenes.array_types import Array
from scenes.arrays import LARGEST
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
    "utf-16": "UTF-16",
}
_MARKS_OF_16 = (b"\xff\xfe", b"\xfe\xff")
# Lines that are looked at before the table is read, bytes that show what it is written in.
_LOOK = 200
_START = 50_000
# How a file begins that is JSON, XML or HTML: no heading does.
_MARKUP = re.compile(r"\s*(?:\{|\[\s*(?:[\[{\"\d-]|$)|<[?!\w])")
_REMARKS = ("#", "**", "%", "//")
SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma", None: "blanks"}
# A number whose digits stand in groups of three: 1,234.5 or 1.234,5 or 1 234 or 1'234.
_GROUPED = re.compile(r"[-+]?\d{1,3}([.,'’ \u00a0\u202f]\d{3})+([.,]\d*)?$")

# Names under which programs write them, compared by `plain`.
ALIASES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t", "step time", "total time", "time value", "steptime", "totaltime", "Zeit"),
    "frame": ("frame", "increment", "inc", "step", "Inkrement"),
    "normal_load": (
        "normal_load",
        "P",
        "normal force",
        "Fn",
        "RF2",
        "load",
        "normal",
        "contact force",
        "clamping force",
        "Normalkraft",
    ),
    "tangential_load": (
        "tangential_load",
        "Q",
        "tangential force",
        "shear force",
        "Ft",
        "RF1",
        "friction force",
        "tangential",
        "Tangentialkraft",
        "Querkraft",
    ),
    "x": (
        "x",
        "X",
        "COORD1",
        "COOR1",
        "X coordinate",
        "true distance",
        "distance",
        "points:0",
        "point x",
        "position",
    ),
    "y": ("y", "Y", "COORD2", "COOR2", "Y coordinate", "points:1", "point y"),
    "pressure": (
        "pressure",
        "p",
        "CPRESS",
        "contact_pressure",
        "normal_contact_stress",
        "Kontaktdruck",
        "Kontaktpressung",
    ),
    "shear": (
        "shear",
        "q",
        "CSHEAR1",
        "CSHEAR",
        "tangential_contact_stress",
        "contact_shear",
        "shear traction",
        "traction",
        "Schubspannung",
        "Kontaktschub",
    ),
    "slip": (
        "slip",
        "s",
        "CSLIP1",
        "CSLIP",
        "tangential_slip",
        "relative_slip",
        "Schlupf",
        "Gleitweg",
    ),
    "displacement": (
        "U",
        "displacement",
        "tangential_displacement",
        "tangential displacement",
        "stroke",
        "Verschiebung",
    ),
    "approach": ("approach", "normal_approach", "normal approach", "indentation"),
    "height": ("h", "height", "gap", "z", "profile", "profile height"),
}
# Of the columns that a scene asks for.
_OF_SCENES = {"P": "normal_load", "Q": "tangential_load", "U": "displacement", "h": "height"}


def plain(name: str) -> str:
    """A column's name without case, blanks, underscores, quotes and what stands in brackets behind
    it.

    A single letter keeps its case: P is a load and p a pressure.

    >>> plain(" Contact_Pressure [MPa]"), plain("CSHEAR1 (top)"), plain("P [N/mm]")
    ('contactpressure', 'cshear1', 'P')
    """
    name_alone = name.split("[", maxsplit=1)[0].split("(", maxsplit=1)[0]
    letters = "".join(letter for letter in name_alone if letter.isalnum() or letter == ":")
    return letters if len(letters) == 1 else letters.lower()


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

    def column(self, name: str) -> Array:
        """The first column of that name, (n_rows,)."""
        return np.asarray(self.values[:, self.names.index(name)])


@dataclass(frozen=True)
class _Layout:
    """Where the table stands in its file: `first` is the line of its first row, `used` are the
    columns that are read.
    """

    separator: str | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    used: tuple[int, ...]
    head: int
    first: int
    skipped: int


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
    columns
        names that are asked for, found by their `ALIASES`; the line of headings may be left out
        where the file has these columns alone, in this order, and a # in a row begins a remark.
        Without: every column
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
    for name, place in request.stated.items():
        if isinstance(place, int) and place < 1:
            raise InputError(
                f"{path}: columns = {{{name} = {place}}} is refused: columns are numbered from 1 on"
            )
    longest_line = _LONGEST if columns else _LONGEST_OF_ALL
    try:
        check_size(path, kind.role, TEXT, kind.cure)
        with path.open("rb") as binary:
            start = binary.read(_START)
        is_utf_16 = start.startswith(_MARKS_OF_16)
        encodings = ["utf-8-sig", "cp1252"]
        if is_utf_16:
            encodings = ["utf-16"]
        elif b"\0" in start:
            encodings = ["utf-8-sig"]
        for encoding in encodings:
            with contextlib.suppress(UnicodeError), path.open(encoding=encoding) as stream:
                lines = partial(_lines, path, stream, longest_line)
                first_lines = list(islice(lines(), _LOOK))
                layout = None
                if kind.numbered and not columns:
                    layout = _rows_alone(first_lines)
                if layout is None:
                    layout = _layout(request, first_lines)
                comma = layout.separator != "," and _has_decimal_comma(lines(), layout)
                values, line_numbers = _numbers(request, lines, layout, comma)
                headings = tuple(layout.names[k] for k in layout.used)
                if not layout.head:
                    headings = tuple(f"column {k + 1}" for k in layout.used)
                return TextTable(
                    names=columns or headings,
                    values=values,
                    lines=line_numbers,
                    headings=headings,
                    units=tuple(layout.units[k] for k in layout.used),
                    separator=SEPARATORS[layout.separator],
                    decimal="comma" if comma else "point",
                    encoding=_ENCODINGS[encoding],
                    head=layout.head,
                    skipped=layout.skipped,
                )
    except OSError as reason:
        raise InputError(f"{path}: the file can't be read: {reason.strerror}") from reason
    raise InputError(
        f"{path}: the file can't be read: it is not {'UTF-16' if is_utf_16 else 'UTF-8'} text"
    )


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
    """The cells of a line; empty ones at its end are none."""
    cells = [cell.strip().strip('"').strip() for cell in text.split(separator)]
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
    return all(
        _number(cell, separator != "," and "," in cell) is not None
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
    words_needed = "a line of names and rows of numbers"
    if columns:
        words_needed = f"{len(columns)} columns {', '.join(columns)}"
    if not lines_without_remarks:
        raise InputError(f"{path}: the file is empty; {words_needed} are needed")
    if _MARKUP.match(lines_without_remarks[0][1]):
        raise InputError(
            f"{path}: this is JSON, XML or HTML and no table: write {words_needed}, separated"
            " by commas"
        )
    fewest_known_headings = (0,) if columns else (2, 0)
    for fewest_known in fewest_known_headings:
        for index in range(len(lines)):
            if _is_row(lines[index][1], max(len(columns), 1)):
                break
            layouts = list(_layouts_below(request, lines, index, fewest_known))
            for layout, has_even_rows in layouts:
                if has_even_rows:
                    return layout
            # Rows without a cell for each heading: a fault of theirs, if nothing else fits.
            if layouts:
                return layouts[0][0]
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
            # The line below the headings may hold the units.
            cells = []
            if lines_below:
                cells = [cell.strip("[]() ") for cell in _cells(lines_below[0][1], mark)]
            has_units = (
                len(cells) == len(names)
                and any(map(is_unit, cells))
                and all(cell in ("", "-") or is_unit(cell) for cell in cells)
            )
            units = [unit_in(name)[1] for name in names]
            if has_units:
                stated_units = [cell.strip("-") for cell in cells]
                units = [
                    stated_unit or unit
                    for stated_unit, unit in zip(stated_units, units, strict=True)
                ]
            rows = lines_below[1:] if has_units else lines_below
            first_row = rows[0][1] if rows else None
            start = rows[0][0] if rows else line_number + 1
            has_even_rows = first_row is None or len(_cells(first_row, mark)) == len(names)
            if is_remark and (
                first_row is None or not has_even_rows or not _numeric(first_row, mark)
            ):
                continue
            layout = _Layout(
                mark, tuple(names), tuple(units), used_columns, line_number, start, len(lines_above)
            )
            yield layout, has_even_rows


def _used(request: _Request, line_number: int, headings: Sequence[str]) -> tuple[int, ...] | None:
    """Which of the headings of a line is that of each wanted column; None where one is not found or
    one stands for two columns.

    Raises
    ------
    InputError
        Where several headings could be that of one column.
    """
    used_columns: list[int] = []
    for column in request.columns:
        places = _places_of(column, request.stated.get(column), headings)
        if len(places) > 1:
            candidates = ", ".join(repr(headings[k]) for k in places)
            raise InputError(
                f"{request.path}, line {line_number}: {candidates} could each be {column}; say"
                f" which by columns = {{{column} = ...}}"
            )
        used_columns += places
    return (
        tuple(used_columns)
        if len(used_columns) == len(request.columns) == len(set(used_columns))
        else None
    )


def _places_of(column: str, stated: str | int | None, headings: Sequence[str]) -> list[int]:
    """Indices of the headings that may be that of a column: as stated, else by its aliases."""
    if isinstance(stated, int):
        return [stated - 1] if stated <= len(headings) else []
    if stated is not None:
        word = stated.strip()
        return [k for k, name in enumerate(headings) if word in (name, unit_in(name)[0])]
    readings = []  # of each heading, with and without what may be its unit
    for name in headings:
        texts = (name, unit_in(name)[0], name_without_unit(name))
        readings.append({plain(text).lower() for text in texts})
    for alias in (column, *ALIASES[_OF_SCENES.get(column, column)]):
        places = [k for k, reading in enumerate(readings) if plain(alias).lower() in reading]
        if places:
            return places
    return []


def _plain_layout(request: _Request, lines: list[Line]) -> _Layout:
    """The layout of rows without a line of headings that was recognised.

    Raises
    ------
    InputError
        For a file that is no such table: what is wrong with it.
    """
    path = request.path
    columns = request.columns
    number, text = lines[0]
    begins_with_rows = any(
        len(_cells(text, mark)) > 1 and _numeric(text, mark) for mark in SEPARATORS
    )
    if not columns:
        fault = f"it is {shown(text)}"
        if begins_with_rows or _numeric(text, None):
            fault = "it has numbers only"
        keys = request.kind.keys_by_number
        cure = f"; or take them by number: {keys}" if keys and begins_with_rows else ""
        raise InputError(
            f"{path}, line {number}: the first line must name the columns, such as"
            f" {request.kind.example}; {fault}{cure}"
        )
    list_of_columns = ", ".join(columns)
    count = len(columns)
    start, mark, cells = _first_row(lines, count)
    exact = (
        start == 0
        and len(cells) == count
        and not any(isinstance(heading, str) for heading in request.stated.values())
    )
    if cells and (request.by_number or exact):
        used_columns = tuple(range(count))
        if request.by_number:
            used_columns = tuple(int(request.stated[name]) - 1 for name in columns)
        if max(used_columns) >= len(cells):
            raise InputError(
                f"{path}, line {lines[start][0]}: there is no column {max(used_columns) + 1}:"
                " the line has"
                f" {len(cells)}"
            )
        column_names = dict(zip(used_columns, columns, strict=True))
        names = [column_names.get(k, f"column {k + 1}") for k in range(len(cells))]
        head, headings, units = _above(lines[:start], mark, len(cells))
        n_skipped = start
        if head:
            n_skipped = sum(line[0] < head for line in lines)
        return _Layout(
            mark,
            headings or tuple(names),
            units or ("",) * len(cells),
            used_columns,
            head,
            lines[start][0],
            n_skipped,
        )
    if begins_with_rows:
        cure = ""
        if len(cells) == 2 * count:
            cure = "; semicolons between the columns where commas stand in the numbers"
        raise InputError(
            f"{path}, line {number}: {count} numbers ({list_of_columns}) are needed, not"
            f" {shown(text)}{cure}; or say which by columns ="
            f" {{{', '.join(f'{name} = {k}' for k, name in enumerate(columns, 1))}}}"
        )
    # the line above the first row of numbers, else the first
    number, text = lines[max(start - 1, 0)]
    separators = (mark,) if cells else tuple(SEPARATORS)
    names = max((way for separator in separators for way in _headings(text, separator)), key=len)
    lacking_columns = [
        name for name in columns if _used(replace(request, columns=(name,)), number, names) is None
    ]
    if not lacking_columns and len(names) >= count:
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
    raise InputError(
        f"{path}, line {number}: the columns are {list_of_columns}, not {shown(text)}:"
        f" {reason}; say which"
        f" by columns = {{{(lacking_columns or columns)[0]} = ...}}, by its heading or its"
        " number from 1 on"
    )


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


def _above(
    lines: list[Line], mark: str | None, count: int
) -> tuple[int, tuple[str, ...], tuple[str, ...]]:
    """Line, headings and units (count,) of columns that were named by number, from the last lines
    above the rows; 0 and none.
    """
    rows = [
        (number, way)
        for number, text in lines
        for way in _headings(text, mark)
        if len(way) == count
    ]
    units: tuple[str, ...] = ()
    if len(rows) > 1 and all(is_unit(cell.strip("[]() ")) for cell in rows[-1][1]):
        units = tuple(cell.strip("[]() ") for cell in rows[-1][1])
        rows.pop()
    if not rows or rows[-1][0] < lines[-1][0] - 1:
        return 0, (), ()
    number, names = rows[-1]
    return number, tuple(names), units or tuple(unit_in(name)[1] for name in names)


def _has_decimal_comma(lines: Iterator[Line], layout: _Layout) -> bool:
    """Whether commas are the decimal sign: the first row with either sign in a column that is read
    decides.

    Of both signs it is the later one in a cell that has both: the other one stands between
    thousands, and is refused.
    """
    for number, text in lines:
        if number < layout.first or not ("," in text or "." in text):
            continue
        cells = _cells(text, layout.separator)
        used_cells = [cells[k] for k in layout.used if k < len(cells)]
        points = any("." in cell for cell in used_cells)
        commas = any("," in cell for cell in used_cells)
        if points or commas:
            return commas and (
                not points or any(0 <= cell.find(".") < cell.rfind(",") for cell in used_cells)
            )
    return False


def _numbers(
    request: _Request, lines: Callable[[], Iterator[Line]], layout: _Layout, comma: bool
) -> tuple[Array, NDArray[np.int64]]:
    """The numbers (n, m) of the columns that are read and the line (n,) of each row; `comma` is
    whether that is the decimal sign.

    All rows are read at once; where that fails, cell by cell up to the fault.
    """
    path = request.path
    mark = layout.separator
    separators_in_row = len(layout.names) - 1
    remarks_in_rows = bool(request.columns)
    line_numbers = array("q")

    def rows() -> Iterator[Line]:
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
        for _, text in rows():
            # empty cells at the end are none
            row = text if mark is None else text.rstrip(f"{mark} ")
            separator_count = len(row.split()) - 1 if mark is None else row.count(mark)
            if separator_count != separators_in_row or (comma and "." in row):
                raise ValueError
            yield row.replace(",", ".") if comma else row

    if next(rows(), None) is None:
        headings = ", ".join(layout.names[k] for k in layout.used[:6])
        remainder = ", ..." if len(layout.used) > 6 else ""
        raise InputError(f"{path}: no row of numbers below the names {headings}{remainder}")
    try:
        values = np.loadtxt(
            even_rows(), delimiter=mark, comments=None, ndmin=2, usecols=layout.used
        )
    except InputError:
        raise
    except ValueError:
        values = np.array([[np.nan]])
    if not (np.abs(values) <= LARGEST).all():
        cells = chain.from_iterable(
            _row(path, number, text, layout, comma) for number, text in rows()
        )
        values = np.fromiter(cells, dtype=float).reshape(-1, len(layout.used))
    return values, np.array(line_numbers, dtype=np.int64)


def _row(path: Path, line: int, text: str, layout: _Layout, comma: bool) -> list[float]:
    """The numbers of one row; InputError for another count, or a cell that is none."""
    cells = _cells(text, layout.separator)
    if len(cells) != len(layout.names):
        list_of_names = ", ".join(layout.names[:6]) + (", ..." if len(layout.names) > 6 else "")
        cure = ""
        if layout.separator == "," and len(cells) > len(layout.names):
            cure = (
                "; commas between the columns leave points for the numbers, without marks between"
                " thousands"
            )
        raise InputError(
            f"{path}, line {line}: {len(layout.names)} numbers ({list_of_names}) are needed, not"
            f" {shown(text)}{cure}"
        )
    numbers: list[float] = []
    for k in layout.used:
        number = _number(cells[k], comma)
        if number is None or not abs(number) <= LARGEST:
            cure = ""
            if _GROUPED.match(cells[k]):
                cure = (
                    f"; the decimal sign of this file is a {'comma' if comma else 'point'}: write"
                    " no marks between thousands"
                )
            raise InputError(
                f"{path}, line {line}: {layout.names[k]} = {shown(cells[k])} is not a finite number"
                f" of at most {LARGEST:g}{cure}"
            )
        numbers.append(number)
    return numbers
