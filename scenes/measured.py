"""Measured tables: columns of numbers from CSV files or lists; a profile through the rows of x and h, that both engines take."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo, model_validator
from pydantic_core import CoreSchema, core_schema

from scenes.errors import InputError, shown
from scenes.files import TEXT, check_size
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

    @abc.abstractmethod
    def check_rows(self) -> None:
        """RowError for the first row that is at fault."""

    @model_validator(mode="after")
    def _check(self, info: ValidationInfo) -> Self:
        try:
            self.check_rows()
        except RowError as fault:
            path, place = _folder(info) / (self.file or ""), f"{self.table}, row {fault.row + 1}"
            if self.file is not None and path.is_file():  # where the rows came from
                place = f"{path}, line {text_table(path, self.columns).lines[fault.row]}"
            raise ValueError(f"{place}: {fault.rule}") from fault
        return self


def _folder(info: ValidationInfo) -> Path:
    """Where the scene file lies."""
    return Path((info.context or {}).get("folder", "."))


def read_table(path: Path, names: tuple[str, ...]) -> Table:
    """The columns `names` of a CSV file; a first line of these names may be there, lines that start with # are skipped.

    Raises
    ------
    InputError
        One sentence that names file, line and rule.
    """
    return Table.of(text_table(path, names).values)


@dataclass(frozen=True, eq=False)
class TextTable:
    """The numbers of a text file: `names` of its columns, `values` (n_rows, n_columns), `lines` (n_rows,) where they stand."""

    names: tuple[str, ...]
    values: Array
    lines: tuple[int, ...]

    def column(self, name: str) -> Array:
        """The first column of that name, (n_rows,)."""
        return np.asarray(self.values[:, self.names.index(name)])


def text_table(path: Path, columns: tuple[str, ...] = (), what: str = "the table", cure: str = "thin it out") -> TextTable:
    """Rows of finite numbers below a line of names; lines that start with # or ** are remarks.

    Parameters
    ----------
    columns : names that the file must have, commas between them; the line of names may then be left out, and a # in a row
        begins a remark. Without: whatever the first line names, with commas, semicolons (then a decimal comma will do), tabs or
        blanks between
    what, cure : what the file is to the user, and what to do about one that is too large

    Raises
    ------
    InputError
        One sentence that names file, line and rule.
    """
    longest = _LONGEST if columns else TEXT  # a row of a foreign table may hold all the frames of a point
    try:
        check_size(path, what, TEXT, cure)
        with path.open("rb") as lines:  # counted before anything of it is kept
            for number, line in enumerate(iter(lambda: lines.readline(longest + 1), b""), 1):
                if len(line) > longest:
                    raise InputError(f"{path}, line {number}: more than {longest:,} characters are no row of a table")
                if number > MOST_ROWS:
                    raise InputError(f"{path}: {what} has more than {MOST_ROWS:,} lines, the most that are read; {cure}")
        text = path.read_text(encoding=_ENCODING)
    except (OSError, UnicodeDecodeError) as reason:
        why = reason.strerror if isinstance(reason, OSError) else "it is not UTF-8 text"
        raise InputError(f"{path}: the file can't be read: {why}") from reason
    bare = ((number, line.split("#", 1)[0] if columns else line) for number, line in enumerate(text.split("\n"), 1))
    rows = [(number, line.strip(" \r")) for number, line in bare if line.strip() and not line.lstrip().startswith(("#", "**"))]
    del text
    wanted = f"{len(columns)} columns {', '.join(columns)}" if columns else "a line of names and rows of numbers"
    if not rows:
        raise InputError(f"{path}: the file is empty; {wanted} are needed")
    first, head = rows[0]
    mark = "," if columns else next((sign for sign in ("\t", ";", ",") if sign in head), None)
    names = tuple(cell.strip().strip('"').strip() for cell in head.split(mark))
    if not columns and all(_is_number(name) for name in names):
        raise InputError(
            f"{path}, line {first}: the first line must name the columns, such as time,x,pressure,shear; it has numbers only"
        )
    if not columns or not any(_is_number(name) for name in names):
        if columns and [name.lower() for name in names] != [name.lower() for name in columns]:
            semicolons = _CURE if ";" in head or "\t" in head else ""
            raise InputError(f"{path}, line {first}: the columns are {', '.join(columns)}, not {shown(head)}{semicolons}")
        del rows[0]
    names = columns or names
    if not rows:
        raise InputError(
            f"{path}: no row of numbers{f'; {wanted} are needed' if columns else ' below the names ' + ', '.join(names)}"
        )
    try:
        values = np.loadtxt([line for _, line in rows], delimiter=mark, comments=None, ndmin=2)
        sound = values.shape == (len(rows), len(names)) and bool((np.abs(values) <= LARGEST).all())
    except ValueError:
        sound = False
    if not sound:  # one by one: decimal commas, a comma at the end of each row; else the first fault
        values = np.array([_numbers(path, number, line, mark, names) for number, line in rows])
    return TextTable(names, values, tuple(number for number, _ in rows))


def _numbers(path: Path, line: int, text: str, mark: str | None, names: tuple[str, ...]) -> list[float]:
    """The numbers of one row; InputError for another count, or a cell that is none."""
    cells = [cell.strip().strip('"') for cell in text.split(mark)]
    if len(cells) == len(names) + 1 and not cells[-1]:
        cells.pop()
    if len(cells) != len(names):
        listed = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        cure = _CURE if mark == "," and len(cells) == 2 * len(names) else ""  # as many as decimal commas would make
        raise InputError(f"{path}, line {line}: {len(names)} numbers ({listed}) are needed, not {shown(text)}{cure}")
    for name, cell in zip(names, cells, strict=True):
        number = cell.replace(",", ".") if mark == ";" else cell
        if not _is_number(number) or not abs(float(number)) <= LARGEST:
            raise InputError(f"{path}, line {line}: {name} = {shown(cell)} is not a finite number of at most {LARGEST:g}")
    return [float(cell.replace(",", ".")) for cell in cells]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


_ALIKE = 1e-12
# Of a slope: what two neighbouring secants of rows on a line may differ by. Their rounding is less, and those of a parabola differ
# by one part in as many as there are rows.
_IN_LINE = 1e-9
# Of an interval between two rows: nearer than this to an end there is no further knot. What it costs the curve is that share of a
# slope; a shorter piece has no digits left in its curvature.
_SHORTEST = 1e-6
# Of x: rows nearer to each other than this have no slope between them that rounding leaves.
_CLOSEST = 1e-9
# Rows of one side. The normal load is a sum over all of them: 2,000 take 0.2 s, and the fields of a cycle some seconds.
_MOST = 2_000
# A rise counts as a whole number of steps to this; steps are coarse where half of all rises are less than so many.
_WHOLE, _COARSE = 1e-3, 1000


class Spline(NamedTuple):
    """h'' constant between knots: `x` (n + 1,) from 0 up, `height`, `slope` there (n + 1,), `curvature` (n,) between them."""

    x: Array
    height: Array
    slope: Array
    curvature: Array


class Tabulated(FromFile):
    """Gap given by rows of x and h, joined by Schumaker's quadratic spline: it rises where the rows rise, bends up where they do.

    Rows of x >= 0 alone, or of both sides, which are then averaged. Beyond the last row the profile goes on straight.

    >>> rows = [[x / 4, x * x / 32] for x in range(5)]
    >>> [round(float(h), 12) for h in Tabulated(points=rows).height([0.1, 1.0])]  # x^2/2
    [0.005, 0.5]
    """

    table, columns = "points", ("x", "h")

    kind: Literal["tabulated"] = "tabulated"
    file: str | None = Field(None, description="CSV file with the columns x, h; path relative to the scene file")
    points: Table = Field(description="the rows themselves, [x, h] each, in place of a file, length units (library: mm)")
    asymmetry: float = Field(1e-3, ge=0, description="admitted difference of the two sides over the largest gap")

    def check_rows(self) -> None:
        one_sided(self.points.values, self.asymmetry)

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: none told; it does a little at every row."""
        return ()

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: the last x of the table."""
        return float(np.max(self.points.values[:, 0]))

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return f"a profile of {len(self.points)} tabulated rows up to {self.datum_length:.6g} {length}"

    def spline(self) -> Spline:
        """The curve for x >= 0."""
        return rising_spline(*one_sided(self.points.values, self.asymmetry))

    def row_before(self, distance: float) -> int:
        """Number, counted from 0, of the last row with x <= `distance` [length]."""
        return int(np.searchsorted(self.points.values[:, 0], distance, side="right")) - 1

    def place(self, row: int) -> str:
        """Where the user finds a row, counted from 0."""
        return f"profile.file = {self.file!r}, row {row + 1}" if self.file else f"profile.points, row {row + 1}"

    def step_of_heights(self) -> float | None:
        """The step in which h is written [length], where rises of neighbouring rows are few of these; None where it is finer."""
        rise = np.abs(np.diff(one_sided(self.points.values, self.asymmetry)[1]))
        step = float(np.min(rise[rise > 0]))
        whole = np.max(np.abs(rise / step - np.round(rise / step))) < _WHOLE
        return step if whole and np.median(rise) < _COARSE * step else None

    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        distance, spline = np.abs(np.asarray(x, dtype=float)), self.spline()
        number = np.clip(np.searchsorted(spline.x, distance, side="right") - 1, 0, len(spline.x) - 1)
        step = distance - spline.x[number]
        bend = np.append(spline.curvature, 0.0)[number]
        return np.asarray(spline.height[number] + step * (spline.slope[number] + bend * step / 2))


def one_sided(points: Array, asymmetry: float) -> tuple[Array, Array]:
    """(x, h) from x = 0, h = 0 up.

    Raises
    ------
    RowError
        x that does not ascend, no row at x = 0, sides that differ, h that falls.
    """
    if points.shape[1] != 2:
        raise RowError(0, f"two numbers (x, h) are needed, not {points.shape[1]}")
    x, h = points.T
    back = np.flatnonzero(np.diff(x) <= 0)
    if len(back):
        raise RowError(int(back[0]) + 1, f"x = {x[back[0] + 1]:.6g} does not ascend")
    close = np.flatnonzero(np.diff(x) < _CLOSEST * np.maximum(np.abs(x[1:]), np.abs(x[:-1])))
    if len(close):
        raise RowError(
            int(close[0]) + 1,
            f"x = {x[close[0] + 1]:.17g} is nearer to the row before than {_CLOSEST:g} of itself: leave one of the two out",
        )
    if len(x[x >= 0]) < 3 or not np.any(x == 0):
        raise RowError(0, "a row with x = 0 and at least two with x > 0 are needed")
    centre = int(np.flatnonzero(x == 0)[0])
    if centre:
        h = _averaged(x, h, centre, asymmetry)
    x, h = x[centre:], h[centre:] - h[centre]
    if len(x) > _MOST:
        rule = f"the profile has {len(x):,} rows of x >= 0, and at most {_MOST:,} are taken: leave out all but every n-th"
        raise RowError(centre + _MOST, rule)
    falls = np.flatnonzero(np.diff(h) < 0)
    if len(falls):
        raise RowError(
            centre + int(falls[0]) + 1, f"h = {points[centre + falls[0] + 1, 1]:.6g} falls: the profile must rise for x > 0"
        )
    if h[-1] == 0:
        raise RowError(len(points) - 1, "the profile is flat from end to end: it must rise somewhere")
    return x, h


def _averaged(x: Array, h: Array, centre: int, asymmetry: float) -> Array:
    """h with the mean of both sides for x > 0."""
    right, left = x[centre:], -x[centre::-1]
    if len(right) != len(left) or np.any(np.abs(right - left) > 1e-9 * x[-1]):
        row = 0 if len(left) > len(right) else len(x) - 1
        raise RowError(row, f"x = {x[row]:.6g} has no partner on the other side: both sides, or x >= 0 alone")
    limit = asymmetry * float(np.max(h) - np.min(h))
    apart = np.flatnonzero(np.abs(h[centre:] - h[centre::-1]) > limit)
    if len(apart):
        raise RowError(centre + int(apart[0]), f"the profile is not symmetric: the sides differ by more than {limit:.3g} there")
    mean = h.copy()
    mean[centre:] = (h[centre:] + h[centre::-1]) / 2
    return mean


def rising_spline(x: Array, h: Array) -> Spline:
    """Schumaker's spline (SIAM J. Numer. Anal. 20, 1983): slopes by parabolas through three rows, one more knot where needed."""
    secant = np.diff(h) / np.diff(x)
    slope = _slopes(x, secant)
    begin, end = slope[:-1] - secant, slope[1:] - secant
    bent = np.flatnonzero(np.abs(begin + end) > _ALIKE * (slope[:-1] + slope[1:]))
    # Where the curvature changes within an interval: where both parts bend the same way, else, with an inflection, in its middle.
    turns = begin * end < 0
    share = np.where(turns, end / np.where(turns, end - begin, 1.0), 0.5)[bent]
    share = np.clip(share, _SHORTEST, 1 - _SHORTEST)
    between = 2 * secant[bent] - share * slope[bent] - (1 - share) * slope[bent + 1]
    at = np.insert(x, bent + 1, x[bent] + share * (x[bent + 1] - x[bent]))
    tangent = np.maximum(np.insert(slope, bent + 1, between), 0.0)  # below 0 by rounding alone
    rises = np.diff(at) * (tangent[:-1] + tangent[1:]) / 2
    return Spline(at, np.concatenate([[0.0], np.cumsum(rises)]), tangent, np.diff(tangent) / np.diff(at))


def _slopes(x: Array, secant: Array) -> Array:
    """Slopes at the rows: of the parabola through three of them, 0 in the middle of the profile, never beyond twice a secant.

    Where three rows lie on a line the spline follows it: any other slope at its ends would bend it back.
    """
    step = np.diff(x)
    slope = np.zeros(len(x))
    slope[1:-1] = (secant[:-1] * step[1:] + secant[1:] * step[:-1]) / (step[:-1] + step[1:])
    alike = np.concatenate([[False], np.abs(np.diff(secant)) <= _IN_LINE * np.maximum(secant[:-1], secant[1:]), [False]])
    along = np.where(alike[:-1] | alike[1:], secant, np.inf)
    line = np.minimum(along[:-1], along[1:])
    slope[1:-1] = np.where(np.isfinite(line), line, slope[1:-1])
    slope[-1] = 2 * secant[-1] - slope[-2]
    slope[1:-1] = np.minimum(slope[1:-1], 2 * np.minimum(secant[:-1], secant[1:]))
    slope[-1] = np.clip(slope[-1], 0.0, 2 * secant[-1])
    return slope
