"""A measured profile: a table of x and h, and the smooth rising curve through it that both engines take as the question."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, ValidationInfo, model_validator

from scenes.tables import FromFile, RowError, Table

Array = NDArray[np.float64]
_ALIKE = 1e-12


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
    file: str | None = Field(None, description="CSV file of the columns x, h (length units); path relative to the scene file")
    points: Table = Field(description="the rows themselves, [x, h] each, in place of a file")
    asymmetry: float = Field(1e-3, ge=0, description="admitted difference of the two sides, as a share of the largest gap")

    @model_validator(mode="after")
    def _rises(self, info: ValidationInfo) -> Self:
        try:
            one_sided(self.points.values, self.asymmetry)
        except RowError as fault:
            raise ValueError(f"{self.place_of(fault, info)}: {fault.rule}") from fault
        return self

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
    if len(x[x >= 0]) < 3 or not np.any(x == 0):
        raise RowError(0, "a row with x = 0 and at least two with x > 0 are needed")
    centre = int(np.flatnonzero(x == 0)[0])
    if centre:
        h = _averaged(x, h, centre, asymmetry)
    x, h = x[centre:], h[centre:] - h[centre]
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
    knots, slopes = [0.0], [float(slope[0])]
    for k, (left, right) in enumerate(pairwise(x.tolist())):
        begin, end, mean = float(slope[k]), float(slope[k + 1]), float(secant[k])
        if abs(begin + end - 2 * mean) > _ALIKE * (begin + end):
            between = _extra_knot(left, right, begin - mean, end - mean)
            share = (between - left) / (right - left)
            knots.append(between)
            slopes.append(2 * mean - share * begin - (1 - share) * end)
        knots.append(right)
        slopes.append(end)
    at, tangent = np.array(knots), np.maximum(slopes, 0.0)
    rises = np.diff(at) * (tangent[:-1] + tangent[1:]) / 2
    return Spline(at, np.concatenate([[0.0], np.cumsum(rises)]), tangent, np.diff(tangent) / np.diff(at))


def _slopes(x: Array, secant: Array) -> Array:
    """Slopes at the rows: of the parabola through three of them, 0 in the middle of the profile, never beyond twice a secant."""
    step = np.diff(x)
    slope = np.zeros(len(x))
    slope[1:-1] = (secant[:-1] * step[1:] + secant[1:] * step[:-1]) / (step[:-1] + step[1:])
    slope[-1] = 2 * secant[-1] - slope[-2]
    slope[1:-1] = np.minimum(slope[1:-1], 2 * np.minimum(secant[:-1], secant[1:]))
    slope[-1] = np.clip(slope[-1], 0.0, 2 * secant[-1])
    return slope


def _extra_knot(left: float, right: float, begin: float, end: float) -> float:
    """Where the curvature changes within an interval; `begin`, `end`: slopes at its ends less the secant."""
    if begin * end >= 0:
        return (left + right) / 2
    if abs(end) < abs(begin):
        return left + (right - left) * end / (end - begin)
    return right + (right - left) * begin / (end - begin)
