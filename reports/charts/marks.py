"""What figures are made of, as values: axes, their scales and ticks, marks in the units of the axes that they are drawn in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

# ------------------------------------------------------------------------------------------------------ places and ticks
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scale:
    """An axis: numbers from `low` to `high` lie on places from `start` to `end`; `log` for a logarithmic one."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def place(self, values: ArrayLike) -> Array:
        """Places of `values`; NaN where there is none, a logarithm of what is not positive among them.

        >>> Scale(0.0, 2.0, 0.0, 100.0).place([0.5]), Scale(1.0, 100.0, 0.0, 1.0, log=True).place([10.0])
        (array([25.]), array([0.5]))
        """
        numbers, low, high = np.asarray(values, dtype=float), self.low, self.high
        if self.log:
            numbers = np.where(numbers > 0, numbers, np.nan)
            numbers, low, high = np.log10(numbers), float(np.log10(low)), float(np.log10(high))
        return np.asarray(self.start + (numbers - low) / (high - low) * (self.end - self.start))

    @property
    def words(self) -> str:
        """For a script: low, high, start, end, and whether it is logarithmic."""
        return f"{self.low:.9g} {self.high:.9g} {self.start:.6g} {self.end:.6g} {int(self.log)}"


def ticks(low: float, high: float, count: int = 5, *, log: bool = False) -> list[float]:
    """Round numbers from low to high, about `count` of them; powers of ten on a logarithmic axis, 1, 2, 5 on a short one.

    >>> ticks(-1.2, 1.2), ticks(1e-4, 1.0, log=True), ticks(0.9, 9.0, log=True)
    ([-1.0, -0.5, 0.0, 0.5, 1.0], [0.0001, 0.001, 0.01, 0.1, 1.0], [1.0, 2.0, 5.0])
    >>> ticks(-17.0, 17.0, 3)
    [-10.0, 0.0, 10.0]
    """
    if log:
        powers = np.arange(np.ceil(np.log10(low) - 1e-9), np.floor(np.log10(high) + 1e-9) + 1)
        if len(powers) < 3:
            powers = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
            steps = [s * 10.0**p for p in powers for s in (1, 2, 5)]
            return [float(f"{s:.12g}") for s in steps if low * (1 - 1e-9) <= s <= high * (1 + 1e-9)]
        every = -(-len(powers) // (count + 1))
        return [float(f"{10.0**p:.12g}") for p in powers[::every]]
    rough = (high - low) / count
    power = 10.0 ** np.floor(np.log10(rough))
    steps = [s * power for s in (1, 2, 2.5, 5, 10)]
    coarse = next(k for k, step in enumerate(steps) if step >= 0.999 * rough)
    # One number says nothing of an axis' scale: then the next finer step, which is below `rough` and has more than one.
    numbers = next(n for n in (_multiples(low, high, steps[k]) for k in (coarse, max(coarse - 1, 0))) if len(n) > 1 or not coarse)
    return [float(f"{n:.12g}") + 0.0 for n in numbers]


def _multiples(low: float, high: float, step: float) -> Array:
    return np.asarray(np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1) * step)


def labels(numbers: Sequence[float]) -> list[str]:
    """Numbers as they stand beside an axis, with a minus sign that is one.

    >>> labels([-0.5, 0.0, 0.5]), labels([0.0, 20000.0]), labels([1e-06, 2e-06])
    (['−0.5', '0', '0.5'], ['0', '20000'], ['1e−6', '2e−6'])
    """
    return [_label(number) for number in numbers]


def _label(number: float) -> str:
    text = f"{number:.6g}"
    if 0 < abs(number) < 1e-3:
        text = np.format_float_scientific(number, precision=5, trim="-")
    if "e" in text:
        mantissa, power = text.split("e")
        text = f"{mantissa}e{int(power)}"
    return text.replace("-", "−")


def limits(*values: ArrayLike, margin: float = 0.06, least: float = 0.0, zero: bool = False) -> tuple[float, float]:
    """From the least to the largest finite value with a margin on both sides; never empty.

    Parameters
    ----------
    margin : share of the range; least : smallest range; zero : whether 0 must be in it
    """
    everything = np.concatenate([np.ravel(np.asarray(v, dtype=float)) for v in values])
    finite = everything[np.isfinite(everything)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    spread = max(high - low, least, 1e-9 * max(abs(low), abs(high)), 1e-300)
    if high - low < spread:
        middle = (low + high) / 2
        low, high = middle - spread / 2, middle + spread / 2
    return low - margin * spread, high + margin * spread


@dataclass(frozen=True)
class Axis:
    """What an axis shows: from `low` to `high`, its words, whether it is logarithmic, about how many ticks (0: none), or which."""

    low: float
    high: float
    words: str
    log: bool = False
    count: int = 5
    ticks: tuple[tuple[float, str], ...] = ()


# `css` names the look in templates/charts.css; `data` goes to the page's script.


@dataclass(frozen=True, eq=False)
class Curve:
    """A line through points; a NaN breaks it. `label` is what a pointer shows for it."""

    x: ArrayLike
    y: ArrayLike
    css: str
    label: str = ""
    data: Mapping[str, object] = field(default_factory=dict)
    closed: bool = False  # joined to its start, for outlines and filled shapes


@dataclass(frozen=True, eq=False)
class Band:
    """The area between two curves; a NaN leaves a gap."""

    x: ArrayLike
    low: ArrayLike
    high: ArrayLike
    css: str
    label: str = ""


# Of the axes: what segments that a page holds once are rounded to.
GRAIN = 2e-4


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines (n, 2, 2) between places. A page holds them once, where panels show the same ones under one `name`.

    There they are whole numbers of `GRAIN`; a panel that uses those of another has "again" after the name.
    """

    ends: NDArray[np.float64]
    css: str
    name: str = ""


@dataclass(frozen=True)
class Dot:
    """A round mark, `radius` in units of the drawing; `fill` where its colour stands for a number."""

    x: float
    y: float
    css: str
    radius: float = 4.0
    label: str = ""
    data: Mapping[str, object] = field(default_factory=dict)
    fill: str = ""


@dataclass(frozen=True)
class Rule:
    """A line across the whole area: at one x if upright, else at one y."""

    at: float
    css: str
    upright: bool = False


@dataclass(frozen=True)
class Block:
    """A rectangle between two x and two y; `fill` where its colour stands for a number; `hatched` for what is not resolved."""

    x: tuple[float, float]
    y: tuple[float, float]
    css: str = ""
    label: str = ""
    fill: str = ""
    hatched: bool = False


@dataclass(frozen=True, eq=False)
class Bitmap:
    """A map over the whole area, first row on top: (n, m) numbers of `colours` (#rrggbb each), or (n, m, 3) colours themselves."""

    pixels: NDArray[np.uint8]
    colours: Sequence[str] = ()


@dataclass(frozen=True)
class Note:
    """A text that starts, ends or has its middle at a place, moved by `shift` units of the drawing (right, down)."""

    x: float
    y: float
    text: str
    css: str = "tick"
    anchor: Literal["start", "middle", "end"] = "start"
    shift: tuple[float, float] = (0.0, 0.0)
    data: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Arrow:
    """An arrow from `start` to `end`."""

    start: tuple[float, float]
    end: tuple[float, float]
    css: str = "arrow"


@dataclass(frozen=True)
class Group:
    """Marks that the page's script replaces together."""

    marks: tuple[Mark, ...]
    css: str
    data: Mapping[str, object]


Mark: TypeAlias = Curve | Band | Segments | Dot | Rule | Block | Bitmap | Note | Arrow | Group


@dataclass(frozen=True)
class Frame:
    """The area of a drawing that curves lie in, with its axes; y grows upwards."""

    x: Scale
    y: Scale
    width: float
    height: float

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom."""
        return self.x.start, self.y.end, self.x.end, self.y.start
