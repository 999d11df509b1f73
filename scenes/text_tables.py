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
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from scenes.arrays import LARGEST
from scenes.errors import InputError, shown
from scenes.files import TEXT, check_size
from scenes.unit_words import is_unit, name_without_unit, unit_in

Array = NDArray[np.float64]

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
    "height": ("h", "height", "gap", "z", "profile", "profile height"),
}
# Of the columns that a scene asks for.
_OF_SCENES = {"P": "normal_load", "Q": "tangential_load", "h": "height"}


def plain(name: str) -> str:
    """A column's name without case, blanks, underscores, quotes and what stands in brackets behind
    it.

    A single letter keeps its case: P is a load and p a pressure.

    >>> plain(" Contact_Pressure [MPa]"), plain("CSHEAR1 (top)"), plain("P [N/mm]")
    ('contactpressure', 'cshear1', 'P')
    """
    bare = name.split("[", maxsplit=1)[0].split("(", maxsplit=1)[0]
    letters = "".join(letter for letter in bare if letter.isalnum() or letter == ":")
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


def text_table(
    path: Path,
    columns: tuple[str, ...] = (),
    what: str = "the table",
    cure: str = "thin it out",
    stated: Mapping[str, str | int] | None = None,
    known: Callable[[str], bool] = lambda _heading: False,
    example: str = "time,x,pressure,shear",
    numbered: bool = False,
    by_number: str = "",
) -> TextTable:
    """Rows of finite numbers below a line of headings; lines that start with #, **, % or // are
    remarks.

    Parameters
    ----------
    columns
        names that are asked for, found by their `ALIASES`; the line of headings may be left out
        where the file has these columns alone, in this order, and a # in a row begins a remark.
        Without: every column
    what, cure
        what the file is to the user, and what to do about one that is too large
    stated
        heading, or number from 1 on, of columns that the user named
    known
        whether a heading is one of those expected, where no columns are asked for
    example, by_number
        headings of this kind of table, and the keys that take columns by number instead, for
        the sentence
    numbered
        whether rows without a line of headings are read where no columns are asked for, as
        "column 1" and so on

    Raises
    ------
    InputError
        One sentence that names file, line, column, value and rule.
    """
    for name, own in (stated or {}).items():
        if isinstance(own, int) and own < 1:
            raise InputError(
                f"{path}: columns = {{{name} = {own}}} is refused: columns are numbered from 1 on"
            )
    longest = _LONGEST if columns else _LONGEST_OF_ALL
    try:
        check_size(path, what, TEXT, cure)
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
                lines = partial(_lines, path, stream, longest)
                first_lines = list(islice(lines(), _LOOK))
                layout = _rows_alone(first_lines) if numbered and not columns else None
                if layout is None:
                    layout = _layout(
                        path, first_lines, columns, stated or {}, known, (example, by_number)
                    )
                comma = layout.separator != "," and _has_decimal_comma(lines(), layout)
                values, numbers = _numbers(
                    path, lines, layout, comma, bool(columns), f"{path}: {what}", cure
                )
                headings = tuple(layout.names[k] for k in layout.used)
                units = tuple(layout.units[k] for k in layout.used)
                if not layout.head:
                    headings = tuple(f"column {k + 1}" for k in layout.used)
                words = (
                    SEPARATORS[layout.separator],
                    "comma" if comma else "point",
                    _ENCODINGS[encoding],
                )
                return TextTable(
                    columns or headings,
                    values,
                    numbers,
                    headings,
                    units,
                    *words,
                    layout.head,
                    layout.skipped,
                )
    except OSError as reason:
        raise InputError(f"{path}: the file can't be read: {reason.strerror}") from reason
    raise InputError(
        f"{path}: the file can't be read: it is not {'UTF-16' if is_utf_16 else 'UTF-8'} text"
    )


def _lines(path: Path, stream: TextIO, longest: int) -> Iterator[Line]:
    """Number and text of every line that is not empty, from the first on."""
    stream.seek(0)
    for number, line in enumerate(iter(partial(stream.readline, longest + 1), ""), 1):
        if len(line) > longest:
            raise InputError(
                f"{path}, line {number}: more than {longest:,} characters are no row of a table"
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
    bare = [(number, text) for number, text in lines if not text.startswith(_REMARKS)]
    if not bare:
        return None
    number, text = bare[0]
    for mark in SEPARATORS:
        cells = _cells(text, mark)
        if len(cells) > 1 and _numeric(text, mark):
            names = tuple(f"column {k + 1}" for k in range(len(cells)))
            return _Layout(mark, names, ("",) * len(cells), tuple(range(len(cells))), 0, number, 0)
    return None


def _layout(
    path: Path,
    lines: list[Line],
    columns: tuple[str, ...],
    stated: Mapping[str, str | int],
    known: Callable[[str], bool],
    words: tuple[str, str],
) -> _Layout:
    """How the table stands in the file, from its first lines."""
    bare = [(number, text) for number, text in lines if not text.startswith(_REMARKS)]
    listed = ", ".join(columns)
    wanted = (
        f"{len(columns)} columns {listed}" if columns else "a line of names and rows of numbers"
    )
    if not bare:
        raise InputError(f"{path}: the file is empty; {wanted} are needed")
    if _MARKUP.match(bare[0][1]):
        raise InputError(
            f"{path}: this is JSON, XML or HTML and no table: write {wanted}, separated by commas"
        )
    least = max(len(columns), 1)
    by_number = bool(columns) and all(isinstance(stated.get(name), int) for name in columns)
    # Where no columns are asked for: a line with two known headings, else the first line of two
    # words or more.
    for least_known in (0,) if columns else (2, 0):
        for place, (number, text) in enumerate(lines):
            remark = text.startswith(_REMARKS)
            if not remark and any(
                len(_cells(text, mark)) >= least and _numeric(text, mark) for mark in SEPARATORS
            ):
                break
            following = [line for line in lines[place + 1 :] if not line[1].startswith(_REMARKS)]
            # the rows do not have a cell for each heading: a fault of theirs, if nothing else fits
            uneven: list[_Layout] = []
            for mark in SEPARATORS:
                for names in _headings(text.lstrip("#*%/ ") if remark else text, mark):
                    used = (
                        _used(path, number, names, columns, stated)
                        if columns
                        else tuple(range(len(names)))
                    )
                    if used is None or by_number:
                        continue
                    if not columns and (
                        remark or len(names) < 2 or sum(map(known, names)) < least_known
                    ):
                        continue
                    # A line of its own below the headings may hold the units.
                    units = (
                        [cell.strip("[]() ") for cell in _cells(following[0][1], mark)]
                        if following
                        else []
                    )
                    below = len(units) == len(names) and any(map(is_unit, units))
                    below = below and all(unit in ("", "-") or is_unit(unit) for unit in units)
                    units = [unit.strip("-") for unit in units] if below else [""] * len(names)
                    start, row = following[below] if len(following) > below else (number + 1, None)
                    even = row is None or len(_cells(row, mark)) == len(names)
                    if remark and (row is None or not even or not _numeric(row, mark)):
                        continue
                    own = tuple(
                        unit or unit_in(name)[1] for unit, name in zip(units, names, strict=True)
                    )
                    skipped = sum(before < number for before, _ in bare)
                    found = _Layout(mark, tuple(names), own, used, number, start, skipped)
                    if even:
                        return found
                    uneven.append(found)
            if uneven:
                return uneven[0]
    return _plain_layout(path, bare, columns, stated, by_number, words)


def _used(
    path: Path,
    line: int,
    names: Sequence[str],
    columns: tuple[str, ...],
    stated: Mapping[str, str | int],
) -> tuple[int, ...] | None:
    """Which of the headings `names` each wanted column has; None where one is not found."""
    found: list[int] = []
    for column in columns:
        own = stated.get(column)
        if isinstance(own, int):
            places = [own - 1] if own <= len(names) else []
        elif own is not None:
            places = [k for k, name in enumerate(names) if own.strip() in (name, unit_in(name)[0])]
        else:
            aliases = (column, *ALIASES[_OF_SCENES.get(column, column)])
            ways_to_read = ((name, unit_in(name)[0], name_without_unit(name)) for name in names)
            heads = [tuple(plain(text).lower() for text in texts) for texts in ways_to_read]
            ways = (
                [k for k, head in enumerate(heads) if plain(alias).lower() in head]
                for alias in aliases
            )
            places = next(filter(None, ways), [])
        if len(places) > 1:
            both = ", ".join(repr(names[k]) for k in places)
            raise InputError(
                f"{path}, line {line}: {both} could each be {column}; say which by columns ="
                f" {{{column} = ...}}"
            )
        found += places
    return tuple(found) if len(found) == len(columns) == len(set(found)) else None


def _plain_layout(
    path: Path,
    bare: list[Line],
    columns: tuple[str, ...],
    stated: Mapping[str, str | int],
    by_number: bool,
    words: tuple[str, str],
) -> _Layout:
    """Where no line of headings was recognised: rows alone; else what is wrong."""
    number, text = bare[0]
    rows = [mark for mark in SEPARATORS if len(_cells(text, mark)) > 1 and _numeric(text, mark)]
    if not columns:
        what = "it has numbers only" if rows or _numeric(text, None) else f"it is {shown(text)}"
        example, keys = words
        cure = f"; or take them by number: {keys}" if keys and rows else ""
        raise InputError(
            f"{path}, line {number}: the first line must name the columns, such as {example};"
            f" {what}{cure}"
        )
    listed = ", ".join(columns)
    count = len(columns)

    # The first row of numbers, its separator and cells.
    ways = (
        (k, mark, _cells(row, mark))
        for k, (_, row) in enumerate(bare)
        for mark in SEPARATORS
        if _numeric(row, mark)
    )
    start, mark, cells = next((way for way in ways if len(way[2]) >= count), (0, None, []))
    exact = (
        start == 0
        and len(cells) == count
        and not any(isinstance(own, str) for own in stated.values())
    )
    if cells and (by_number or exact):
        used = (
            tuple(int(stated[name]) - 1 for name in columns) if by_number else tuple(range(count))
        )
        if max(used) >= len(cells):
            raise InputError(
                f"{path}, line {bare[start][0]}: there is no column {max(used) + 1}: the line has"
                f" {len(cells)}"
            )
        own = dict(zip(used, columns, strict=True))
        names = [own.get(k, f"column {k + 1}") for k in range(len(cells))]
        head, above, units = _above(bare[:start], mark, len(cells))
        skipped = sum(before < head for before, _ in bare) if head else start
        return _Layout(
            mark,
            above or tuple(names),
            units or ("",) * len(cells),
            used,
            head,
            bare[start][0],
            skipped,
        )
    if rows:
        cure = (
            "; semicolons between the columns where commas stand in the numbers"
            if len(cells) == 2 * count
            else ""
        )
        raise InputError(
            f"{path}, line {number}: {count} numbers ({listed}) are needed, not"
            f" {shown(text)}{cure}; or say which by columns ="
            f" {{{', '.join(f'{name} = {k}' for k, name in enumerate(columns, 1))}}}"
        )
    # the line above the first row of numbers, else the first
    number, text = bare[max(start - 1, 0)]
    names = max(
        (way for one in ((mark,) if cells else SEPARATORS) for way in _headings(text, one)), key=len
    )
    lacking = [name for name in columns if _used(path, number, names, (name,), stated) is None]
    own_words = [shown(stated[name]) for name in lacking if name in stated]
    if not lacking and len(names) >= count:
        raise InputError(
            f"{path}, line {number}: columns: {listed} must be of different columns of"
            f" {shown(text)}"
        )
    which = (
        f"no heading is {' or '.join(own_words)}"
        if own_words
        else f"none is known as {' or '.join(lacking or columns)}"
    )
    cure = (
        f"{which}; say which by columns = {{{(lacking or columns)[0]} = ...}}, by its heading or"
        " its number from 1 on"
    )
    raise InputError(f"{path}, line {number}: the columns are {listed}, not {shown(text)}: {cure}")


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
        used = [cells[k] for k in layout.used if k < len(cells)]
        points = any("." in cell for cell in used)
        commas = any("," in cell for cell in used)
        if points or commas:
            return commas and (
                not points or any(0 <= cell.find(".") < cell.rfind(",") for cell in used)
            )
    return False


def _numbers(
    path: Path,
    lines: Callable[[], Iterator[Line]],
    layout: _Layout,
    comma: bool,
    remarks_in_rows: bool,
    what: str,
    cure: str,
) -> tuple[Array, NDArray[np.int64]]:
    """The numbers of the columns that are read and the line of each row: at once where all is well,
    else one by one to a fault.
    """
    mark = layout.separator
    more = len(layout.names) - 1
    places = array("q")

    def rows() -> Iterator[Line]:
        del places[:]
        for number, text in lines():
            if number < layout.first or text.startswith(_REMARKS):
                continue
            if len(places) == MOST_ROWS:
                raise InputError(
                    f"{what} has more than {MOST_ROWS:,} rows, the most that are read; {cure}"
                )
            places.append(number)
            yield (
                number,
                (text.split("#", 1)[0].rstrip() if remarks_in_rows and "#" in text else text),
            )

    def even_rows() -> Iterator[str]:
        for _, text in rows():
            # empty cells at the end are none
            row = text if mark is None else text.rstrip(f"{mark} ")
            if (len(row.split()) - 1 if mark is None else row.count(mark)) != more or (
                comma and "." in row
            ):
                raise ValueError
            yield row.replace(",", ".") if comma else row

    if next(rows(), None) is None:
        headings = ", ".join(layout.names[k] for k in layout.used[:6])
        rest = ", ..." if len(layout.used) > 6 else ""
        raise InputError(f"{path}: no row of numbers below the names {headings}{rest}")
    try:
        values = np.loadtxt(
            even_rows(), delimiter=mark, comments=None, ndmin=2, usecols=layout.used
        )
    except InputError:
        raise
    except ValueError:
        values = np.array([[np.nan]])
    if not (np.abs(values) <= LARGEST).all():
        each = chain.from_iterable(
            _row(path, number, text, layout, comma) for number, text in rows()
        )
        values = np.fromiter(each, dtype=float).reshape(-1, len(layout.used))
    return values, np.array(places, dtype=np.int64)


def _row(path: Path, line: int, text: str, layout: _Layout, comma: bool) -> list[float]:
    """The numbers of one row; InputError for another count, or a cell that is none."""
    cells = _cells(text, layout.separator)
    if len(cells) != len(layout.names):
        listed = ", ".join(layout.names[:6]) + (", ..." if len(layout.names) > 6 else "")
        cure = ""
        if layout.separator == "," and len(cells) > len(layout.names):
            cure = (
                "; commas between the columns leave points for the numbers, without marks between"
                " thousands"
            )
        raise InputError(
            f"{path}, line {line}: {len(layout.names)} numbers ({listed}) are needed, not"
            f" {shown(text)}{cure}"
        )
    found: list[float] = []
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
        found.append(number)
    return found
