"""The maps (maps.toml), their tables and laws: errors read, fitted over the small parameter, read
off between points, and bounded.

    |e| = C s^n,    s -> 0

The fit is of log |e| = log C + n log s + d s^2. The last term stands for the next one of a series
in s^2 (or of one in s: then it is d s): without it the exponent of points that reach to large s is
wrong by more than its interval. The range is found, not chosen: the largest s are left out until
what is left shows no more curvature in the logarithms than that.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.stats import t as student

from reports.charts.templating import table_text
from reports.studies.sweep.study import Point, expand, load_study
from scenes import InputError
from scenes.array_types import Array

_FEWEST = 5  # points of a fit: three unknowns and two degrees of freedom
_BEND = 2.0  # standard deviations of curvature before a range counts as not asymptotic
_SHARE = 0.1  # of an error, its uncertainty where none was asked for
_SURE = 0.5  # half the interval of an exponent up to which its law is extrapolated
_LEFT_OUT = ("address", "notes", "number", "reason")


# --------------------------------------------------------------------------------------------- maps
STUDIES = Path(__file__).with_name("studies")
PUBLISHED = Path(__file__).parents[2] / "published" / "maps"


def place(at: Mapping[str, str], everywhere: str = "all") -> str:
    """The coordinates of a line in words; `everywhere` where it has none.

    >>> place({"aspect": "2", "base": "fixed"}), place({})
    ('width / height 2, base fixed', 'all')
    """
    return ", ".join(f"{AXES.get(name, name)} {value}" for name, value in at.items()) or everywhere


@dataclass(frozen=True)
class Chart:
    """One study as it is drawn and fitted; maps.toml describes each."""

    study: str
    across: str
    up: str = ""
    panels: str = ""
    small: str = ""
    inverse: bool = False
    expected: float | None = None
    prediction: str = ""
    within: str = ""
    step: float = 2.0
    others: Mapping[str, float] = field(default_factory=dict)
    sample: Mapping[str, Any] = field(default_factory=dict)

    def order(self, figure: str) -> float | None:
        """Exponent of s that theory predicts of an error; None where no law is sought."""
        return self.others.get(figure, self.expected)


@dataclass(frozen=True)
class Map:
    """A page: its charts, and studies of points that no law was fitted to."""

    name: str
    title: str
    question: str
    charts: tuple[Chart, ...]
    held_out: Sequence[str] = ()

    @property
    def studies(self) -> tuple[str, ...]:
        """Every study of the page."""
        return (*(chart.study for chart in self.charts), *self.held_out)


_CONTENT = tomllib.loads(Path(__file__).with_name("maps.toml").read_text(encoding="utf-8"))
PAGE_WORDS: dict[str, Any] = _CONTENT["words"]
WORDS: dict[str, str] = _CONTENT["figures"]
AXES: dict[str, str] = _CONTENT["axes"]
MAPS = {
    row["name"]: Map(**row | {"charts": tuple(Chart(**chart) for chart in row["charts"])})
    for row in _CONTENT["map"]
}


def map_named(name: str) -> Map:
    """A map by name; InputError names those that there are."""
    if name not in MAPS:
        raise InputError(f"map {name!r}: there is none; known: {', '.join(MAPS)}, or all")
    return MAPS[name]


# ------------------------------------------------------------------------------------------- tables
def read(folder: Path, study: str) -> pd.DataFrame:
    """The finished points of a study in `folder`, every cell as text; InputError where there are
    none.
    """
    path = folder / f"{study}.csv"
    try:
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except OSError as reason:
        raise InputError(
            f"{path}: the table of the study can't be read: {reason.strerror}; make it by `make"
            " maps`"
        ) from reason
    except pd.errors.EmptyDataError:
        table = pd.DataFrame()
    if table.empty:
        raise InputError(f"{path}: the table has no rows; make it again by `make maps`")
    return table[table["status"] == "done"]


def numbers(table: pd.DataFrame, column: str) -> Array:
    """A column (n,), NaN where there is none."""
    return np.asarray(pd.to_numeric(table[column]), dtype=np.float64)


def errors(table: pd.DataFrame, name: str) -> tuple[Array, Array]:
    """An error (n,) and its uncertainty (n,), NaN where there is none.

    An error of -1 to the last digit is none either: the finite elements stick throughout, and
    theory's value is round-off.
    """
    error = numbers(table, name)
    doubt = f"{name}.uncertainty"
    return np.where(error == -1.0, np.nan, error), (
        numbers(table, doubt) if doubt in table else np.full(len(table), np.nan)
    )


def figures(table: pd.DataFrame) -> list[str]:
    """Names of its errors."""
    return [
        name
        for name in table.columns
        if name.startswith("error.") and not name.endswith(".uncertainty")
    ]


def parts(
    table: pd.DataFrame, columns: Sequence[str]
) -> Iterator[tuple[dict[str, str], pd.DataFrame]]:
    """The rows for each set of values of `columns`, in the order of the study."""
    named = [name for name in columns if name]
    for key, part in table.groupby(named, sort=False) if named else [((), table)]:
        yield dict(zip(named, key, strict=True)), part


def as_csv(table: pd.DataFrame) -> str:
    """The index of a sweep as it is published: without addresses, seven digits."""
    shown = table.drop(columns=list(_LEFT_OUT)).map(cell_text)
    return table_text({name: shown[name].replace("nan", "").tolist() for name in shown})


def cell_text(value: Any) -> str:
    """A cell of a published table."""
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def points_of(study: str) -> tuple[Point, ...]:
    """The points of a study, with their scenes."""
    return expand(load_study(STUDIES / f"{study}.toml"))


# --------------------------------------------------------------------------------------------- laws
@dataclass(frozen=True)
class Law:
    """|e| = constant s^order where s is at most `largest`; a doubt is half of a 95 % interval."""

    order: float
    order_doubt: float
    constant: float  # at the fitted exponent
    constant_doubt: float
    expected: float  # exponent that theory predicts
    fixed: float  # constant at the expected exponent, on the same points
    fixed_doubt: float
    next_term: float  # d, at the expected exponent: the law holds to a share d s^step
    step: float  # exponent by which the series goes on
    sign: int  # of the error
    smallest: float  # s in the fit
    largest: float
    points: int
    left_out: int  # resolved points at larger s that are not asymptotic
    misfit: float  # reduced chi squared; above 1 the intervals are widened by its root
    # curvature of the logarithms is significant even in the fewest points: no asymptotic range was
    # found
    bent: bool

    def agrees(self) -> bool:
        """Whether the expected exponent is in the interval of the fitted one."""
        return abs(self.order - self.expected) <= self.order_doubt

    def value(self, s: float) -> float:
        """The error by the law at the expected exponent and its next term, with its sign."""
        return self.sign * self.fixed * s**self.expected * math.exp(self.next_term * s**self.step)


def fit_law(
    s: ArrayLike, error: ArrayLike, uncertainty: ArrayLike, expected: float, step: float = 2.0
) -> Law | None:
    """The law of errors (n,) at s (n,), each with its uncertainty (n,); None where fewer than five
    points can be had.

    `expected` is the exponent that theory predicts, `step` that by which its series goes on.
    A point takes part where |error| > uncertainty and where it has the sign of the point with the
    smallest s among these. The point at the largest s is left out, and the next, while logarithms
    are bent or it moves the exponent out of its interval. Intervals have three parts, in
    quadrature: independent errors of standard deviation u, widened by the root of the misfit where
    that is above 1; an error that all points share, as points cut alike do: what the fit moves by
    when all errors move by +-u; and terms that are left out: what it moves by without the point at
    the largest s.

    >>> law = fit_law(
    ...     [0.1, 0.2, 0.3, 0.4, 0.5], [0.02, 0.08, 0.18, 0.32, 0.5], [1e-4] * 5, expected=2
    ... )
    >>> round(law.order, 6), round(law.constant, 6)
    (2.0, 2.0)
    """
    x, e, u = (np.asarray(column, dtype=float) for column in (s, error, uncertainty))
    resolved = np.flatnonzero(np.isfinite(e) & np.isfinite(u) & (np.abs(e) > u) & (x > 0))
    resolved = resolved[np.argsort(x[resolved])]
    if not len(resolved):
        return None
    sign = int(np.sign(e[resolved[0]]))
    # From the first change of sign on, the error is no longer that of the leading term.
    same = np.cumprod(sign * e[resolved] > 0).astype(bool)
    x, e, u = (column[resolved][same] for column in (x, np.abs(e), u))
    if len(x) < _FEWEST:
        return None

    def free(x: Array, e: Array, u: Array, *more: Array) -> tuple[Array, Array, float]:
        """log C, n, d."""
        return _solve(np.log(e), [np.ones_like(x), np.log(x), x**step, *more], e / u)

    def held(x: Array, e: Array, u: Array) -> tuple[Array, Array, float]:
        """log C, d at the expected exponent."""
        return _solve(np.log(e) - expected * np.log(x), [np.ones_like(x), x**step], e / u)

    def is_bent(x: Array, e: Array, u: Array) -> bool:
        found, covariance, _ = free(x, e, u, np.log(x) ** 2)
        return bool(abs(found[3]) > _BEND * math.sqrt(covariance[3, 3]))

    def is_moved(x: Array, e: Array, u: Array) -> bool:
        """Whether the point at the largest s moves the exponent out of its interval."""
        found, covariance, misfit = free(x, e, u)
        interval = _widened(len(x) - len(found), misfit) * math.sqrt(covariance[1, 1])
        return bool(abs(free(x[:-1], e[:-1], u[:-1])[0][1] - found[1]) > interval)

    inside = (
        k
        for k in range(len(x), _FEWEST, -1)
        if not is_bent(x[:k], e[:k], u[:k]) and not is_moved(x[:k], e[:k], u[:k])
    )
    count = next(inside, _FEWEST)
    total = len(x)
    x, e, u = (column[:count] for column in (x, e, u))
    (log, order, _), (log_doubt, order_doubt, _), misfit = _with_doubt(x, e, u, free)
    (log_held, following), (held_doubt, _), _ = _with_doubt(x, e, u, held)
    return Law(
        order=float(order),
        order_doubt=float(order_doubt),
        constant=math.exp(log),
        constant_doubt=math.exp(log) * math.expm1(log_doubt),
        expected=expected,
        fixed=math.exp(log_held),
        fixed_doubt=math.exp(log_held) * math.expm1(held_doubt),
        next_term=float(following),
        step=step,
        sign=sign,
        smallest=float(x[0]),
        largest=float(x[-1]),
        points=len(x),
        left_out=total - len(x),
        misfit=misfit,
        bent=is_bent(x, e, u),
    )


def leading_constant(
    s: ArrayLike, error: ArrayLike, uncertainty: ArrayLike, order: float
) -> tuple[float, float]:
    """k of error = s^order (k + k1 s + k2 s^2 + k3 s^3) by all points (n,), and half its 95 %
    interval (parts as in `fit_law`).

    For a series in s whose second term soon counts: of that, the exponential that `fit_law` takes
    is a poor image.

    >>> s = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    >>> round(leading_constant(s, -s * (2 + 3 * s), 1e-4 * s, 1.0)[0], 6)
    -2.0
    """
    x, e, u = (np.asarray(column, dtype=float) for column in (s, error, uncertainty))
    sign = float(np.sign(e[np.argmin(x)]))

    def series(x: Array, e: Array, u: Array) -> tuple[Array, Array, float]:
        return _solve(e / x**order, [x**power for power in range(4)], x**order / u)

    found, doubt, _ = _with_doubt(x, sign * e, u, series)
    return sign * float(found[0]), float(doubt[0])


def _solve(target: Array, columns: Sequence[Array], weight: Array) -> tuple[Array, Array, float]:
    """Coefficients of the columns, their covariance and the reduced chi squared."""
    design = np.stack(columns, axis=1) * weight[:, None]
    covariance = np.asarray(np.linalg.inv(design.T @ design), dtype=np.float64)
    found = covariance @ (design.T @ (weight * target))
    rest = weight * target - design @ found
    return found, covariance, float(rest @ rest) / max(len(target) - len(columns), 1)


def _widened(freedom: int, misfit: float) -> float:
    """Half of a 95 % interval over the standard deviation that the uncertainties give."""
    return float(student.ppf(0.975, freedom)) * math.sqrt(max(1.0, misfit))


def _with_doubt(
    x: Array, e: Array, u: Array, fit: Callable[[Array, Array, Array], tuple[Array, Array, float]]
) -> tuple[Array, Array, float]:
    """Coefficients of a fit, half their 95 % intervals, and its misfit; see `fit_law`."""
    found, covariance, misfit = fit(x, e, u)
    widen = _widened(len(x) - len(found), misfit)
    # Weights e/u stay those of the errors as measured; a shift through 0 leaves a twentieth.
    moved = [np.maximum(e + way * u, 0.05 * e) for way in (-1.0, 1.0)]
    shared = np.max([np.abs(fit(x, there, u * there / e)[0] - found) for there in moved], axis=0)
    inner = np.argsort(x)[:-1]
    further = (
        np.abs(fit(x[inner], e[inner], u[inner])[0] - found) if len(inner) >= len(found) else 0.0
    )
    return found, np.sqrt(widen**2 * np.diag(covariance) + shared**2 + further**2), misfit


# --------------------------------------------------------------------------------- lines of a chart
@dataclass(frozen=True)
class Line:
    """The points of a chart along its small parameter, other axes fixed at `at`, their law, and the
    exponent of its first term.
    """

    figure: str
    at: Mapping[str, str]
    s: Array
    error: Array
    uncertainty: Array
    law: Law | None
    order: float = 2.0

    @property
    def known(self) -> NDArray[np.bool_]:
        """Points that have an error and an uncertainty."""
        return np.isfinite(self.error) & np.isfinite(self.uncertainty)


def lines(chart: Chart, table: pd.DataFrame, wanted: Sequence[str] = ()) -> Iterator[Line]:
    """Every line of the errors that are wanted; of all where none is named."""
    for figure in [name for name in figures(table) if not wanted or name in wanted]:
        order = chart.order(figure)
        for at, part in parts(table, (chart.panels, chart.up)):
            across = numbers(part, chart.across)
            error, doubt = errors(part, figure)
            law = None
            s = 1 / across if chart.inverse else np.abs(across)
            if order is not None:
                law = fit_law(
                    s,
                    error,
                    doubt if np.isfinite(doubt).any() else _SHARE * np.abs(error),
                    order,
                    chart.step,
                )
            yield Line(figure, at, s, error, doubt, law, order or 2.0)


def along(line: Line, s: float) -> tuple[float, float]:
    """Error and uncertainty at s: error/s^n, n the line's order, is interpolated over log s and
    kept beyond the ends.

    Below the smallest point the law goes on; of its uncertainty nothing is gained.
    """
    order = np.argsort(line.s[line.known])
    at, *columns = (column[line.known][order] for column in (line.s, line.error, line.uncertainty))
    error, doubt = (
        float(np.interp(np.log(s), np.log(at), column / at**line.order)) for column in columns
    )
    return error * s**line.order, doubt * max(s, float(at[0])) ** line.order


@dataclass(frozen=True)
class Bound:
    """The largest s up to which |error| + uncertainty stays below a level; None where there is no
    such point and no law.
    """

    s: float | None
    how: str  # "points": between two of them; "all": the largest tried; "law": extrapolated; "none"


def bound(line: Line, level: float) -> Bound:
    """Read a line from small s upwards; straight in logarithms between the last point below the
    level and the first above.

    Points at which theory's error changes its sign may fall below a level in between: the first
    that exceeds it counts.
    """
    size = np.abs(line.error) + np.nan_to_num(line.uncertainty)
    order = [k for k in np.argsort(line.s) if np.isfinite(size[k])]
    s = line.s[order]
    size = size[order]
    above = np.flatnonzero(size > level)
    if not len(above):
        return Bound(float(s[-1]), "all") if len(s) else Bound(None, "none")
    if (first := int(above[0])) == 0:
        law = line.law
        if law is None or not law.agrees() or law.order_doubt > _SURE:
            return Bound(None, "none")
        return Bound((level / (law.fixed + law.fixed_doubt)) ** (1 / law.expected), "law")
    share = np.log(level / size[first - 1]) / np.log(size[first] / size[first - 1])
    return Bound(float(s[first - 1] * (s[first] / s[first - 1]) ** share), "points")


def bound_in_words(axis_bound: Bound, axis_is_inverse: bool) -> str:
    """For a table: in units of the map's axis, rounded to the safe side; * where extrapolated.

    >>> (
    ...     [
    ...         bound_in_words(Bound(0.1234, "points"), axis_is_inverse)
    ...         for axis_is_inverse in (True, False)
    ...     ],
    ...     bound_in_words(Bound(0.5, "all"), True),
    ... )
    (['8.2', '0.123'], '2 (all tried)')
    """
    if axis_bound.s is None:
        return "none tried"
    value = 1 / axis_bound.s if axis_is_inverse else axis_bound.s
    scale = 10.0 ** (2 - int(np.floor(np.log10(value)))) if value < 1 else 10.0
    rounded = (
        np.ceil(value * scale - 1e-9) if axis_is_inverse else np.floor(value * scale + 1e-9)
    ) / scale
    return f"{rounded:g}" + {"points": "", "all": " (all tried)", "law": "*"}[axis_bound.how]
