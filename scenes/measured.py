"""Measured tables: columns of numbers from CSV files or lists; a profile through the rows of x and h, that both engines take."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Generic, Literal, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PrivateAttr,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import CoreSchema, core_schema

from scenes.errors import InputError, RowError, shown
from scenes.fitting import fitted_keys
from scenes.frozen import Frozen, Positive
from scenes.text_tables import LARGEST, text_table
from scenes.unit_words import Kind, unit_factor

Array = NDArray[np.float64]


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


def _rows_may_stand_in_a_file(schema: dict[str, Any], model: type[FromFile]) -> None:
    schema["required"].remove(model.table)


def _in_tuples(pairs: Any) -> Any:
    """JSON has no tuples, and a table that may read a file is checked as what Python made of it."""
    return tuple(tuple(pair) if isinstance(pair, list) else pair for pair in pairs) if isinstance(pairs, list) else pairs


ReadAs = Annotated[tuple[tuple[str, str], ...], BeforeValidator(_in_tuples)]
# Keys that say how a file is read.
READING = ("columns", "units", "thickness", "scale", "zero", "sign")
# What each of them is, for descriptions.
COLUMNS = "headings or numbers (from 1 on) of the columns in the file, where they are not found by their usual names"
UNITS = "units of the columns in the file, where its headings do not state them; turned into those of the scene"
SCALE, ZERO = "factors of the columns, such as a calibration", "numbers of the file that mean zero: taken off first, in its units"
READ_AS = "how the file was read, found and assumed; written by the reader"


class FromFile(Frozen):
    """Keys of which one, `table`, is rows of numbers that may stand in a text `file` instead, relative to the scene file.

    A number of the scene is sign x scale x unit x (number of the file - zero) / thickness.
    """

    model_config = ConfigDict(json_schema_extra=_rows_may_stand_in_a_file)

    table: ClassVar[str]
    quantities: ClassVar[dict[str, Kind]]
    further: ClassVar[dict[str, Kind]] = {}
    """Keys that are lists, an entry for each row, which may be columns of the file too, where `columns` names them."""

    kind: str
    file: str | None
    read_as: ReadAs | None

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict) or not isinstance(data.get("file"), str) or data.get(cls.table) is not None:
            return data
        stated = {key: data[key] for key in READING if key in cls.model_fields and data.get(key) is not None}
        try:
            for key, value in stated.items():
                field = cls.model_fields[key]
                adapter: TypeAdapter[Any] = TypeAdapter(Annotated[field.annotation, field])  # type: ignore[arg-type]
                stated[key] = adapter.validate_python(value)
        except ValidationError:  # said with its key when the fields are checked, for which rows are needed
            return data | {cls.table: [[0.0] * len(cls.quantities)]}
        units, named = (info.context or {}).get("units"), cls._named(stated.get("columns"))
        wanted = cls.quantities | {name: cls.further[name] for name in named}
        rows, read_as = _columns_of(_folder(info) / data["file"], wanted, stated, units if isinstance(units, str) else _UNITS)
        if both := [name for name in named if data.get(name) is not None]:
            raise InputError(f"{data['file']}: {both[0]} is a column of the file and stated beside it: leave one out")
        count = len(cls.quantities)
        more = {name: tuple(rows.values[:, count + k].tolist()) for k, name in enumerate(named)}
        return data | {cls.table: Table.of(rows.values[:, :count]) if named else rows, "read_as": read_as} | more

    @classmethod
    def _named(cls, columns: Frozen | None) -> list[str]:
        """Which of the further columns a table of `columns` names."""
        return [name for name in _given(columns) if name in cls.further]

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """As for every table; rows of one file are not those of another, nor is a file the source of other rows."""
        data = super().merged(changes)
        if "fitted" not in changes:
            data.pop("fitted", None)
        read = self._named(getattr(self, "columns", None))
        if self.table in changes and "file" not in changes:
            for key in ("file", "read_as", *READING, *(set(read) - changes.keys())):
                data.pop(key, None)
        elif self.table not in changes and data.get("file") is not None and not changes.keys().isdisjoint(("file", *READING)):
            for key in (self.table, "read_as", *(set(read) - changes.keys())):
                data.pop(key, None)
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
                columns = getattr(self, "columns", None)
                place = f"{path}, line {text_table(path, tuple(self.quantities), stated=_given(columns)).lines[fault.row]}"
            raise ValueError(f"{place}: {fault.rule}") from fault
        unused = [key for key in READING if getattr(self, key, None) is not None]
        if self.file is None and unused:
            raise ValueError(
                f"{unused[0]} says how a file is read, and `{self.table}` stand in the units of the scene: leave it out"
            )
        return self


def _folder(info: ValidationInfo) -> Path:
    """Where the scene file lies."""
    return Path((info.context or {}).get("folder", "."))


# Of the library; where nothing else is stated.
_UNITS = "N, mm, MPa"
_SCENE_UNITS = "units of the scene"


def _given(table: Frozen | None) -> dict[str, Any]:
    """What a table with a key for each column states of them."""
    return {} if table is None else {name: value for name, value in table if value is not None}


def _columns_of(path: Path, quantities: Mapping[str, Kind], stated: Mapping[str, Any], units: str) -> tuple[Table, ReadAs]:
    """The rows of a file in the units of the scene, and how they were found: in pairs of words.

    Raises
    ------
    InputError
        One sentence: what the reader refuses, and a unit that can't be right.
    """
    found = text_table(path, tuple(quantities), stated=_given(stated.get("columns")))
    said = [
        ("file", f"{path.name}: {len(found.lines):,} rows from line {found.lines[0]} on"),
        ("columns separated by", found.separator),
        ("decimal sign", found.decimal),
    ]
    if not found.encoding.startswith("UTF-8"):
        said.append(("characters", found.encoding))
    if found.skipped:
        said.append(("lines above the headings", f"{found.skipped} skipped"))
    values, thickness, converted = found.values, stated.get("thickness"), False
    factors, zeros, signs, words = (_given(stated.get(key)) for key in ("scale", "zero", "sign", "units"))
    for k, (name, kind) in enumerate(quantities.items()):
        heading, unit, where = found.headings[k], words.get(name) or found.units[k], "stated" if name in words else "in its heading"
        how, factor, per_length = [f"{heading!r}" if found.head else heading], 1.0, None
        if unit:
            try:
                factor, per_length = unit_factor(unit, kind, units)
            except ValueError as reason:
                if name in words:
                    raise InputError(f"units.{name}: {reason}") from reason
                how.append(f"{unit!r} {where} is no unit that is known: taken as it stands")
            else:
                converted = converted or kind != "time"
                how.append(f"{unit} ({where})" + (f", times {factor:.9g}" if factor != 1 else ""))
        elif kind != "time":
            how.append("no unit stated: taken to be in that of the scene")
        if kind == "load" and per_length is False and thickness is None:
            raise InputError(
                f"{path}: {name} is in {unit} ({where}), a force, and loads are per unit thickness: state the key thickness, the "
                "length of the contact out of the plane, by which it is divided"
            )
        if kind == "load" and per_length and thickness is not None:
            raise InputError(f"{path}: {name} is in {unit} ({where}), per length already: leave out the key thickness")
        if name in zeros:
            how.append(f"zero at {zeros[name]:.9g} of the file")
        if name in factors:
            how.append(f"times {factors[name]:.9g} (scale)")
        if kind == "load" and thickness is not None:
            how.append(f"over the thickness {thickness:.9g}")
        if signs.get(name, 1) < 0:
            how.append("sign turned")
        factor *= factors.get(name, 1.0) * signs.get(name, 1) / (thickness if kind == "load" and thickness is not None else 1.0)
        if name in zeros:
            values[:, k] -= zeros[name]
        if factor != 1:
            with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused with its row
                values[:, k] *= factor
        said.append((name, ", ".join(how)))
    if converted:
        said.append((_SCENE_UNITS, units))
    return Table.of(values), tuple(said)


def read_for(read_as: ReadAs | None) -> str:
    """The units into which the columns of a file were turned; empty where none was."""
    return dict(read_as or ()).get(_SCENE_UNITS, "")


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


T = TypeVar("T")


class OfProfile(Frozen, Generic[T]):
    """One of each column of a profile; what is left out is not stated."""

    x: T | None = None
    h: T | None = None


FitKind = Literal["even_polynomial", "smoothing_spline", "flat_rounded", "hertz"]


class ProfileFit(Frozen):
    """How a smooth, convex and symmetric curve is laid through measured rows; the scene then holds that curve in their place."""

    kind: FitKind = Field(
        description="what is fitted: `hertz`, `flat_rounded`, `even_polynomial` (powers 2 to 8) or `smoothing_spline` (no formula)"
    )
    noise: Positive | None = Field(
        None, description="standard deviation of h, length units (library: mm); left out, that of the residuals"
    )
    centre: float | None = Field(
        None,
        description="x of the middle of the contact, length units (library: mm); fitted if left out, but 0 for rows of one side",
    )
    extent: Positive | None = Field(
        None, description="rows farther from the middle are left out, length units (library: mm); all count if left out"
    )


class Fitted(Frozen):
    """Where fitted numbers came from: written by the fit, so that a saved scene gives the same answer without the file."""

    kind: FitKind = Field(description="what was fitted")
    source: str = Field(description="file with the rows, or `points`")
    rows: Table = Field(description="the rows that were fitted, [x, h] each, length units (library: mm)")
    noise: Positive = Field(description="standard deviation of h, length units (library: mm)")
    noise_stated: bool = Field(description="whether that was stated, or is that of the residuals")
    centre: float = Field(description="x of the middle, length units (library: mm)")
    centre_fitted: bool = Field(description="whether that was fitted")
    offset: float = Field(description="fitted h there, length units (library: mm)")
    residual: float = Field(ge=0, description="root mean square of rows minus curve, length units (library: mm)")
    freedom: int = Field(gt=0, description="rows less fitted numbers")
    extent: Positive = Field(description="distance from the middle that the rows reach on every side that has any (library: mm)")
    weight: float = Field(0.0, ge=0, description="of the smoothing against the rows")
    left_out: int = Field(0, ge=0, description="rows beyond the extent")
    read_as: ReadAs | None = Field(None, description=READ_AS)


class Tabulated(FromFile):
    """Gap given by rows of x and h, joined by Schumaker's quadratic spline: it rises where the rows rise, bends up where they do.

    Rows of x >= 0 alone, or of both sides, which are then averaged. Beyond the last row the profile goes on straight.

    >>> rows = [[x / 4, x * x / 32] for x in range(5)]
    >>> [round(float(h), 12) for h in Tabulated(points=rows).height([0.1, 1.0])]  # x^2/2
    [0.005, 0.5]
    """

    table, quantities = "points", {"x": "length", "h": "length"}

    kind: Literal["tabulated"] = "tabulated"
    file: str | None = Field(None, description="text table with the columns x, h; path relative to the scene file")
    points: Table = Field(description="the rows themselves, [x, h] each, in place of a file, length units (library: mm)")
    symmetric: bool = Field(True, description="false keeps two unequal sides as they are; each must rise from x = 0")
    asymmetry: float = Field(1e-3, ge=0, description="admitted difference of the two sides over the largest gap")
    columns: OfProfile[str | int] | None = Field(None, description=COLUMNS)
    units: OfProfile[str] | None = Field(None, description=UNITS)
    scale: OfProfile[Positive] | None = Field(None, description=SCALE)
    zero: OfProfile[float] | None = Field(None, description=ZERO)
    sign: OfProfile[Literal[1, -1]] | None = Field(None, description="-1 turns a column, such as a height counted the other way")
    read_as: ReadAs | None = Field(None, description=READ_AS)
    fit: ProfileFit | None = Field(None, description="a curve through noisy rows, to be taken in their place")
    fitted: Fitted | None = Field(None, description="where fitted numbers came from; written by `fit`")

    _keys: dict[str, Any] = PrivateAttr(default_factory=dict)

    def check_rows(self) -> None:
        if self.fit is None:
            self._sides()
        else:
            self._keys = fitted_keys(*self.points.values.T, **dict(self.fit))

    def _sides(self) -> tuple[tuple[Array, Array], ...]:
        """(x, h) from x = 0, h = 0 up: of both sides averaged, or of the left side, turned round, and of the right."""
        rows = self.points.values
        if self.symmetric:
            return (one_sided(rows, self.asymmetry),)
        turned = rows[rows[:, 0] <= 0][::-1] * [-1.0, 1.0] if rows.shape[1] == 2 else rows
        try:
            left = one_sided(turned, self.asymmetry)
        except RowError as fault:
            raise RowError(max(len(turned) - 1 - fault.row, 0), f"left side, x counted to the left: {fault.rule}") from fault
        try:
            return left, one_sided(rows[rows[:, 0] >= 0], self.asymmetry)
        except RowError as fault:
            raise RowError(len(rows[rows[:, 0] < 0]) + fault.row, fault.rule) from fault

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: none told; it does a little at every row."""
        return ()

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: the largest x of the table."""
        return float(np.max(self.points.values[:, 0]))

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return f"a profile of {len(self.points)} tabulated rows up to {self.datum_length:.6g} {length}"

    def curve(self) -> dict[str, Any]:
        """The keys of the profile that `fit` makes of the rows: what stands in a scene in place of this one."""
        more = {"source": self.file or self.table, "rows": self.points, "read_as": getattr(self, "read_as", None)}
        return self._keys | {"fitted": self._keys["fitted"] | more}

    def spline(self) -> Spline:
        """The curve for x >= 0; InputError for rows that are to be fitted, which are another profile in a scene."""
        if self.fit is not None:
            raise InputError("profile: rows with the key `fit` are to be part of a scene; without one take scenes.fit_profile")
        if not self.symmetric:
            raise InputError("profile: its two sides are unequal, and each has a spline of its own: take `sides`")
        return self.sides()[-1]

    def sides(self) -> tuple[Spline, Spline]:
        """The curve to the left of x = 0, x counted to the left, and to the right."""
        found = [rising_spline(*side) for side in self._sides()]
        return found[0], found[-1]

    def row_before(self, distance: float) -> int:
        """Number, counted from 0, of the last row with x <= `distance` [length]."""
        return int(np.searchsorted(self.points.values[:, 0], distance, side="right")) - 1

    def place(self, row: int) -> str:
        """Where the user finds a row, counted from 0."""
        return f"profile.file = {self.file!r}, row {row + 1}" if self.file else f"profile.points, row {row + 1}"

    def step_of_heights(self) -> float | None:
        """The step in which h is written [length], where rises of neighbouring rows are few of these; None where it is finer."""
        rise = np.abs(np.diff(self._sides()[-1][1]))
        step = float(np.min(rise[rise > 0]))
        whole = np.max(np.abs(rise / step - np.round(rise / step))) < _WHOLE
        return step if whole and np.median(rise) < _COARSE * step else None

    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        if self.symmetric or self.fit is not None:
            return _on(self.spline(), np.abs(np.asarray(x, dtype=float)))
        at, (left, right) = np.asarray(x, dtype=float), self.sides()
        return np.asarray(np.where(at < 0, _on(left, np.abs(at)), _on(right, np.abs(at))))


def _on(spline: Spline, distance: Array) -> Array:
    """h at distances >= 0 from x = 0, any shape; straight beyond the last knot."""
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
