"""The marks that figures are made of, as values. Their places are in the units of the axes that they are drawn in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.charts.scale import Scale


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
