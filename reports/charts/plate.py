"""A figure as a value: axes and marks in their units, panels, the key to its lines, its words and
numbers; and its form as SVG.

On a page the style sheet colours a panel, so that it follows dark mode and print; alone it carries
its colours. Words are escaped in `_element` and `_Pen.words` and nowhere else.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.charts.templating import (
    STATE_NAMES,
    Table,
    pieces,
    shades,
    style_of,
    table_text,
    template,
)

# --------------------------------------------------------------------------------- places and ticks
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scale:
    """An axis: numbers from `low` to `high` lie on places from `start` to `end`; `log` for a
    logarithmic one.
    """

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def place(self, values: ArrayLike) -> Array:
        """Places of `values`; NaN where there is none, a logarithm of what is not positive among
        them.

        >>> (
        ...     Scale(0.0, 2.0, 0.0, 100.0).place([0.5]),
        ...     Scale(1.0, 100.0, 0.0, 1.0, log=True).place([10.0]),
        ... )
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


def _ticks(low: float, high: float, count: int = 5, *, log: bool = False) -> list[float]:
    """Round numbers from low to high, about `count` of them; powers of ten on a logarithmic axis,
    1, 2, 5 on a short one.

    >>> _ticks(-1.2, 1.2), _ticks(1e-4, 1.0, log=True), _ticks(0.9, 9.0, log=True)
    ([-1.0, -0.5, 0.0, 0.5, 1.0], [0.0001, 0.001, 0.01, 0.1, 1.0], [1.0, 2.0, 5.0])
    >>> _ticks(-17.0, 17.0, 3)
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
    # One number says nothing of an axis' scale: then the next finer step, which is below `rough`
    # and has more than one.
    numbers = next(
        n
        for n in (_multiples(low, high, steps[k]) for k in (coarse, max(coarse - 1, 0)))
        if len(n) > 1 or not coarse
    )
    return [float(f"{n:.12g}") + 0.0 for n in numbers]


def _multiples(low: float, high: float, step: float) -> Array:
    return np.asarray(
        np.arange(np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9) + 1) * step
    )


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


def limits(
    *values: ArrayLike, margin: float = 0.06, least: float = 0.0, zero: bool = False
) -> tuple[float, float]:
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
    """What an axis shows: from `low` to `high`, its words, whether it is logarithmic, about how
    many ticks (0: none), or which.
    """

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
_GRAIN = 2e-4


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines (n, 2, 2) between places. A page holds them once, where panels show the same
    ones under one `name`.

    There they are whole numbers of `GRAIN`; a panel that uses those of another has "again" after
    the name.
    """

    ends: NDArray[np.float64]
    css: str
    name: str = ""


@dataclass(frozen=True)
class Dot:
    """A round mark, `radius` in units of the drawing; `fill` where its colour stands for a
    number.
    """

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
    """A rectangle between two x and two y; `fill` where its colour stands for a number; `hatched`
    for what is not resolved.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    css: str = ""
    label: str = ""
    fill: str = ""
    hatched: bool = False


@dataclass(frozen=True, eq=False)
class Bitmap:
    """A map over the whole area, first row on top: (n, m) numbers of `colours` (#rrggbb each), or
    (n, m, 3) colours themselves.
    """

    pixels: NDArray[np.uint8]
    colours: Sequence[str] = ()


@dataclass(frozen=True)
class Note:
    """A text that starts, ends or has its middle at a place, moved by `shift` units of the drawing
    (right, down).
    """

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


# ------------------------------------------------------------------------------------------- panels
# Room around the area of the curves for words and numbers [units of a drawing, in which letters are
# 12 high].
_LEFT, RIGHT, _TOP, _BOTTOM, _LINE = 72.0, 20.0, 12.0, 46.0, 15.0
_UNIT = Scale(0.0, 1.0, 0.0, 1.0)
# Of a line of more places only those that show stay: in each strip so wide the first, the last, the
# highest and the lowest.
_LONG_LINE, _STRIP = 2000, 1.0
DOWN = "3.5"  # how far a subscript stands below its line [units of a drawing]
_HATCH = 7.0  # distance of the lines of a hatched block [units of a drawing]


@dataclass(frozen=True, eq=False)
class Panel:
    """Two axes and marks."""

    name: str  # used once on a page
    x: Axis
    y: Axis
    marks: Sequence[Mark]
    alt: str  # what it shows, for who can't see it
    # width, height: of the drawing
    width: float = 440.0
    height: float = 300.0
    # title, notes: lines above the area; notes hold the numbers of a plot
    title: str = ""
    notes: Sequence[str] = ()
    # "x" or "y" where that axis is the time, so that the instant shown is marked on it
    time: str = ""
    css: str = ""
    # one scale for both axes, the one with room to spare showing more on both sides
    equal: bool = False
    bare: bool = False  # no axes at all
    # left, top, right, bottom of it beside the area, automatic if None
    room: tuple[float, float, float, float] | None = None

    @property
    def frame(self) -> Frame:
        """The area that the marks lie in."""
        above = _TOP + _LINE * (len(self.notes) + bool(self.title))
        left, top, right, bottom = self.room or (
            _LEFT,
            above,
            RIGHT,
            _BOTTOM if self.x.words else 24.0,
        )
        (x0, x1), (y0, y1) = (self.x.low, self.x.high), (self.y.low, self.y.high)
        across, up = self.width - left - right, self.height - top - bottom
        if self.equal:
            unit = max((x1 - x0) / across, (y1 - y0) / up)
            (x0, x1), (y0, y1) = (
                ((a + b - unit * size) / 2, (a + b + unit * size) / 2)
                for a, b, size in ((x0, x1, across), (y0, y1, up))
            )
        horizontal = Scale(x0, x1, left, self.width - right, self.x.log)
        return Frame(
            horizontal,
            Scale(y0, y1, self.height - bottom, top, self.y.log),
            self.width,
            self.height,
        )

    def __html__(self) -> str:
        """The panel on a page."""
        return _panel_svg(self)


@dataclass(frozen=True, eq=False)
class Cell:
    """Panels that belong together, one under the other; where it has an `event`, a click shows that
    instant of the cycle.
    """

    panels: tuple[Panel, ...]
    event: int | None

    def __html__(self) -> str:
        inside = "".join(panel.__html__() for panel in self.panels)
        return (
            f"<div>{inside}</div>"
            if self.event is None
            else f'<div class="cell" data-event="{self.event:d}">{inside}</div>'
        )


@dataclass(frozen=True)
class Key:
    """An entry of a legend: the look of its lines or patches, and what they stand for."""

    css: str
    text: str
    patch: bool = False


STATE_KEYS = tuple(
    Key(f"state-{int(state)}", name, patch=True) for state, name in STATE_NAMES.items()
)


@dataclass(frozen=True, eq=False)
class Plate:
    """A figure."""

    name: str  # stem of its files
    # title, caption: for the page
    title: str
    caption: str
    alt: str  # what it shows, for who can't see it
    panels: tuple[Panel | Cell, ...]  # set side by side where there is room, at most `columns`
    table: Table  # column heading (with unit) -> values, all of one length; what the figure draws
    keys: tuple[Key, ...] = ()  # the legend, above the panels
    columns: int = 2

    def svg(self) -> str:
        """The whole figure as a document of its own: its legend in rows, beneath it its panels in
        columns, with their colours.
        """
        parts = stacks(self)
        columns = min(self.columns, len(parts))
        across = [max(stack[0].width for stack in parts[c::columns]) for c in range(columns)]
        width, left, top, pen, drawn = (
            sum(across),
            10.0,
            6.0,
            _Pen(Frame(*(_UNIT,) * 2, 0, 0), alone=True),
            [],
        )
        for key in self.keys:
            size = 44.0 + 6.6 * len(key.text)  # letters 12 high are 6.6 wide in the mean
            if left > 10.0 and left + size > width:
                left, top = 10.0, top + 18.0
            line = _element(
                "path",
                d=f"M{left:g} {top + 7:g}L{left + 24:g} {top + 7:g}",
                **pen.look(f"curve {key.css}"),
            )
            patch = _element(
                "rect", x=left + 4, y=top + 2, width=16, height=10, **pen.look(f"{key.css} patch")
            )
            drawn += [
                patch if key.patch else line,
                pen.words(left + 30, top + 11, key.text, "word"),
            ]
            left += size
        top = top + 22.0 if self.keys else 0.0
        for k in range(0, len(parts), columns):
            lowest = top
            for column, stack in enumerate(parts[k : k + columns]):
                place = top
                for panel in stack:
                    box = {
                        "x": sum(across[:column]),
                        "y": place,
                        "width": panel.width,
                        "height": panel.height,
                    }
                    drawn.append(_panel_svg(panel, alone=True, **box))
                    place += panel.height
                lowest = max(lowest, place)
            top = lowest
        ground = _element("rect", width=width, height=top, fill="#ffffff")
        return _element(
            "svg",
            f"<title>{escape(self.title)}</title>{ground}{''.join(drawn)}",
            xmlns="http://www.w3.org/2000/svg",
            width=f"{width:g}",
            height=f"{top:g}",
            viewBox=f"0 0 {width:g} {top:g}",
            font_family="DejaVu Sans, Segoe UI, sans-serif",
            font_size="12",
        )

    def csv(self) -> str:
        """The table, numbers to the last digit; an empty cell stands for "no such thing"."""
        return table_text(self.table)

    def __html__(self) -> str:
        """The figure on a page: legend, panels, caption."""
        return str(template("figure.html").module.drawn(self))  # type: ignore[attr-defined]


def worded(
    name: str,
    panels: Sequence[Panel | Cell],
    table: Table,
    keys: Sequence[Key] = (),
    *,
    columns: int = 2,
    words: str = "",
    **numbers: object,
) -> Plate:
    """A figure of the page: its title, its caption and what it shows are in templates/figures.txt
    under `words`, or its name.
    """
    written = getattr(template("figures.txt").module, words or name)(**numbers)
    title, caption, alt = str(written).strip().split("\n")
    return Plate(name, title, caption, alt, tuple(panels), table, tuple(keys), columns)


def stacks(plate: Plate) -> list[tuple[Panel, ...]]:
    """The panels of a figure, those of a cell together."""
    return [part.panels if isinstance(part, Cell) else (part,) for part in plate.panels]


def colour_scale(
    name: str,
    low: float,
    high: float,
    words: str,
    colours: str = "viridis",
    *,
    log: bool = False,
    own: Sequence[float] = (),
    width: float = 480.0,
) -> Panel:
    """What the colours of a map stand for; `own` ticks where round numbers are not wanted."""
    high = high if high > low else low + (abs(low) or 1.0)
    row = Bitmap(
        np.arange(64, dtype=np.uint8)[None, :], shades((np.arange(64) + 0.5) / 64, colours)
    )
    numbers = (
        [value for value in own if low <= value <= high] if own else _ticks(low, high, 4, log=log)
    )
    axis = Axis(low, high, words, log, ticks=tuple(zip(numbers, labels(numbers), strict=True)))
    return Panel(
        name,
        axis,
        Axis(0.0, 1.0, "", count=0),
        [row],
        f"Colours: {words}",
        width,
        74.0,
        css="colours",
    )


def _attributes(given: Mapping[str, object]) -> str:
    """Attributes as text, "_" in a name read as "-", empty ones left out.

    >>> _attributes({"data_label": 'a "b"', "x": 1.5, "class_": ""})
    ' data-label="a &quot;b&quot;" x="1.5"'
    """
    parts = (
        (
            name.rstrip("_").replace("_", "-"),
            f"{v:.2f}".rstrip("0").rstrip(".") if isinstance(v, float) else str(v),
        )
        for name, v in given.items()
        if v is not None and v != ""
    )
    return "".join(f' {name}="{escape(value)}"' for name, value in parts)


def _element(name: str, content: str = "", /, **given: object) -> str:
    """An element; `content` is SVG already. A place that is no number draws nothing."""
    if any(isinstance(value, float) and not math.isfinite(value) for value in given.values()):
        return ""
    return (
        f"<{name}{_attributes(given)}>{content}</{name}>"
        if content
        else f"<{name}{_attributes(given)}/>"
    )


def _path_of(horizontal: ArrayLike, vertical: ArrayLike, off: float = 0.0, passes: int = 0) -> str:
    """A line through places; a NaN breaks it. Places that repeat the last one to a hundredth are
    left out, and see `_LONG_LINE`.

    In each of `passes` every other place goes that lies within `off` of the straight line between
    its neighbours.

    >>> (
    ...     _path_of([0, 1, np.nan, 2, 3], [0, 1, 1, 1, 1]),
    ...     _path_of([0, 1, 2, 3, 4], [0, 0, 0, 0, 5], 0.1, 2),
    ... )
    ('M0 0L1 1M2 1L3 1', 'M0 0L3 0L4 5')

    A place that stands alone is a line to itself, which round ends make a dot.

    >>> _path_of([0, np.nan, 2], [0, 1, 1])
    'M0 0L0 0M2 1L2 1'
    """
    across, down = (
        np.round(np.asarray(horizontal, dtype=float), 2),
        np.round(np.asarray(vertical, dtype=float), 2),
    )
    good = np.isfinite(across) & np.isfinite(down)
    if len(across) > _LONG_LINE:
        strips = np.where(good, np.floor(across / _STRIP), np.nan)
        # of places that follow each other
        strip = np.concatenate([[0], np.cumsum(strips[1:] != strips[:-1])])
        by_height = np.lexsort((np.where(good, down, 0.0), strip))
        first = np.flatnonzero(np.diff(strip, prepend=-1))
        last = np.append(first[1:], len(strip)) - 1
        shown = np.unique(np.concatenate([first, last, by_height[first], by_height[last]]))
        across, down, good = across[shown], down[shown], good[shown]
    moved = np.ones(len(across), dtype=bool)
    moved[1:] = (across[1:] != across[:-1]) | (down[1:] != down[:-1]) | ~good[:-1]
    starts = good & ~np.concatenate([[False], good[:-1]])
    alone = starts & ~np.concatenate([good[1:], [False]])
    rows = np.flatnonzero(good & moved)
    for _ in range(passes):
        before, here, after = (rows[k : len(rows) - 2 + k : 2] for k in range(3))
        chord, apart = (
            np.array([across[to] - across[before], down[to] - down[before]]) for to in (after, here)
        )
        away = np.abs(chord[0] * apart[1] - chord[1] * apart[0]) <= off * np.hypot(*chord)
        rows = rows[~np.isin(rows, here[away & ~starts[here] & ~starts[after]])]
    places = {k: f"{across[k]:g} {down[k]:g}" for k in rows.tolist()}
    return "".join(
        f"M{at}L{at}" if alone[k] else f"{'M' if starts[k] else 'L'}{at}"
        for k, at in places.items()
    )


def _png(pixels: NDArray[np.uint8], colours: Sequence[str] = (), *, whole: bool = False) -> bytes:
    """A picture as a PNG file: (n, m) numbers of `colours`, or (n, m, 3) colours, of which 255 are
    kept unless `whole`.

    >>> _png(np.zeros((1, 1), np.uint8), ["#ffffff"])[:8]
    b'\\x89PNG\\r\\n\\x1a\\n'
    """
    from PIL import Image

    picture, stream = Image.fromarray(pixels), io.BytesIO()
    if colours:
        picture.putpalette(b"".join(bytes.fromhex(colour.removeprefix("#")) for colour in colours))
    elif not whole:
        picture = picture.quantize(255)
    picture.save(stream, "PNG", optimize=not whole)
    return stream.getvalue()


@dataclass(frozen=True)
class _Pen:
    """Draws marks in a frame; `alone` in a document without a style sheet."""

    frame: Frame
    alone: bool

    def look(self, css: str, *, text: bool = False) -> dict[str, object]:
        """Classes on a page, declarations in a document of its own."""
        if not self.alone:
            return {"class_": css}
        kept = {
            name: value
            for name, value in style_of(css, text=text).items()
            if name not in ("vector-effect", "cursor")
        }
        return {"style": ";".join(f"{name}:{value}" for name, value in kept.items())}

    def words(self, x: float, y: float, text: str, css: str, /, **given: object) -> str:
        """A text at a place of the drawing, with its subscripts."""
        parts = pieces(text)
        content = escape(text)
        if len(parts) > 1:
            down, content = False, ""
            for part, low in parts:
                shift = {"dy": DOWN if low else f"-{DOWN}"} if low is not down else {}
                size: dict[str, object] = self.look("sub") if low else {}
                content += (
                    _element("tspan", escape(part), **shift, **size)
                    if shift or size
                    else escape(part)
                )
                down = low
        return _element(
            "text", content, x=float(x), y=float(y), **self.look(css, text=True), **given
        )

    def data(self, given: Mapping[str, object]) -> dict[str, object]:
        return {} if self.alone else {f"data_{name}": value for name, value in given.items()}

    def draw(self, mark: Mark) -> str:
        """A mark as SVG."""
        frame = self.frame
        left, top, right, bottom = frame.box
        match mark:
            case Curve():
                # a pointer on a page needs points everywhere
                thin = (0.1, 8) if self.alone else (0.02, 1)
                d = _path_of(frame.x.place(mark.x), frame.y.place(mark.y), *thin) or "M0 0"
                given = self.data({"label": mark.label} | dict(mark.data))
                return _element(
                    "path",
                    d=d + ("Z" if mark.closed else ""),
                    **self.look(f"curve {mark.css}"),
                    **given,
                )
            case Band():
                along, low, high = (
                    np.asarray(values, dtype=float) for values in (mark.x, mark.low, mark.high)
                )
                known, d = np.isfinite(low) & np.isfinite(high), ""
                for run in np.split(np.arange(len(known)), np.flatnonzero(np.diff(known)) + 1):
                    # a gap ends one outline, and the next begins behind it
                    if len(run) and known[run[0]]:
                        there, back = along[run], np.concatenate([low[run], high[run][::-1]])
                        d += (
                            _path_of(frame.x.place([*there, *there[::-1]]), frame.y.place(back))
                            + "Z"
                        )
                return _element("path", d=d or "M0 0", **self.look(f"band {mark.css}"))
            case Segments():
                return self.segments(mark)
            case Dot():
                x, y = float(frame.x.place(mark.x)), float(frame.y.place(mark.y))
                given = {"fill": mark.fill or None} | self.data(
                    {"label": mark.label} | dict(mark.data)
                )
                return _element("circle", cx=x, cy=y, r=mark.radius, **self.look(mark.css), **given)
            case Rule():
                place = float((frame.x if mark.upright else frame.y).place(mark.at))
                x1, y1, x2, y2 = (
                    (place, top, place, bottom) if mark.upright else (left, place, right, place)
                )
                return _element("line", x1=x1, x2=x2, y1=y1, y2=y2, **self.look(mark.css))
            case Block():
                return self.block(mark)
            case Bitmap():
                address = (
                    "data:image/png;base64,"
                    + base64.b64encode(_png(mark.pixels, mark.colours, whole=self.alone)).decode()
                )
                box = {"x": left, "y": top, "width": right - left, "height": bottom - top}
                return _element(
                    "image", **box, href=address, preserveAspectRatio="none", **self.look("map")
                )
            case Note():
                x, y = float(frame.x.place(mark.x)), float(frame.y.place(mark.y))
                given = {"dx": mark.shift[0] or None, "dy": mark.shift[1] or None} | self.data(
                    mark.data
                )
                anchor = None if mark.anchor == "start" else mark.anchor
                return "".join(
                    self.words(x, y + _LINE * k, line, mark.css, text_anchor=anchor, **given)
                    for k, line in enumerate(mark.text.split("\n"))
                )
            case Arrow():
                return self.arrow(mark)
            case Group():
                inside = "".join(self.draw(one) for one in mark.marks) or " "
                return _element("g", inside, **self.look(mark.css), **self.data(mark.data))

    def segments(self, mark: Segments) -> str:
        """All of them as one path: on a page in whole numbers, so that another window can use it
        again.
        """
        frame, look = self.frame, self.look(mark.css)
        if self.alone or not mark.name:
            x, y = frame.x.place(mark.ends[..., 0]), frame.y.place(mark.ends[..., 1])
            seen = (x.max(axis=1) >= frame.x.start) & (x.min(axis=1) <= frame.x.end)
            seen &= (y.max(axis=1) >= frame.y.end) & (y.min(axis=1) <= frame.y.start)
            lines = zip(np.round(x[seen], 2).tolist(), np.round(y[seen], 2).tolist(), strict=True)
            return _element(
                "path",
                d="".join(f"M{a:g} {c:g}L{b:g} {d:g}" for (a, b), (c, d) in lines) or "M0 0",
                **look,
            )
        zoom = (frame.x.end - frame.x.start) / (frame.x.high - frame.x.low) * _GRAIN
        x0, y0 = float(frame.x.place(0.0)), float(frame.y.place(0.0))
        transform = f"translate({x0:.3f} {y0:.3f}) scale({zoom:.7g} {-zoom:.7g})"
        if "again" in mark.name.split():
            return _element(
                "g", _element("use", href=f"#{mark.name.split()[0]}"), transform=transform
            )
        whole = np.rint(mark.ends / _GRAIN).astype(int)
        moves = (whole[:, 1] - whole[:, 0]).tolist()
        d = "".join(
            f"M{x} {y}l{dx} {dy}"
            for (x, y), (dx, dy) in zip(whole[:, 0].tolist(), moves, strict=True)
        )
        return _element("g", _element("path", d=d, id=mark.name, **look), transform=transform)

    def block(self, mark: Block) -> str:
        (left, right), (low, high) = (
            np.sort(self.frame.x.place(mark.x)),
            np.sort(self.frame.y.place(mark.y)),
        )
        place = {
            "x": float(left),
            "y": float(low),
            "width": float(right - left),
            "height": float(high - low),
        }
        given = {"fill": mark.fill or None} | self.data({"label": mark.label})
        filled = _element("rect", **place, **self.look(mark.css), **given)
        if not mark.hatched:
            return filled
        # Lines of slope 1: x + y is constant along each.
        sums = (
            np.arange(np.ceil((left + low) / _HATCH), np.floor((right + high) / _HATCH) + 1)
            * _HATCH
        )
        begin, end = np.maximum(left, sums - high), np.minimum(right, sums - low)
        lines = zip(begin.tolist(), end.tolist(), sums.tolist(), strict=True)
        d = "".join(f"M{a:.1f} {s - a:.1f}L{b:.1f} {s - b:.1f}" for a, b, s in lines if b > a)
        return filled + (_element("path", d=d, **self.look("hatching")) if d else "")

    def arrow(self, mark: Arrow) -> str:
        """A line from the first to the second place with a head at the second."""
        places = np.array([mark.start, mark.end])
        first, tip = np.column_stack(
            [self.frame.x.place(places[:, 0]), self.frame.y.place(places[:, 1])]
        )
        along = (tip - first) / np.hypot(*(tip - first))
        across = np.array([-along[1], along[0]])
        head = np.array([tip, tip - 11 * along + 4.5 * across, tip - 11 * along - 4.5 * across])
        end = tip - 9 * along
        line = _element(
            "path",
            d=_path_of([first[0], end[0]], [first[1], end[1]]),
            **self.look(f"curve {mark.css}"),
        )
        return line + _element(
            "path", d=_path_of(head[:, 0], head[:, 1]) + "Z", **self.look(f"head {mark.css}")
        )

    def axes(self, x: Axis, y: Axis) -> str:
        """Grid lines, numbers beside the axes, and what the axes show."""
        frame = self.frame
        left, top, right, bottom = frame.box
        parts = []
        for place, text in (
            (float(frame.x.place(number)), text) for number, text in _tick_pairs(x, frame.x)
        ):
            parts.append(
                _element("line", x1=place, x2=place, y1=top, y2=bottom, **self.look("grid across"))
            )
            if frame.height - bottom > 16:
                parts.append(
                    self.words(place, bottom + 15, text, "tick across", text_anchor="middle")
                )
        for place, text in (
            (float(frame.y.place(number)), text) for number, text in _tick_pairs(y, frame.y)
        ):
            parts.append(
                _element("line", x1=left, x2=right, y1=place, y2=place, **self.look("grid upright"))
            )
            parts.append(self.words(left - 6, place + 4, text, "tick upright", text_anchor="end"))
        middle = (top + bottom) / 2
        if x.words and frame.height - bottom > 30:
            parts.append(
                self.words((left + right) / 2, bottom + 36, x.words, "name", text_anchor="middle")
            )
        if y.words:
            parts.append(
                self.words(
                    12,
                    middle,
                    y.words,
                    "name",
                    text_anchor="middle",
                    transform=f"rotate(-90 12 {middle:g})",
                )
            )
        return "".join(parts)


def _tick_pairs(axis: Axis, scale: Scale) -> tuple[tuple[float, str], ...]:
    """Each tick of an axis with its text: the axis' own, or round numbers."""
    if axis.ticks or not axis.count:
        return axis.ticks
    numbers = _ticks(scale.low, scale.high, axis.count, log=axis.log)
    return tuple(zip(numbers, labels(numbers), strict=True))


def _panel_svg(panel: Panel, *, alone: bool = False, **place: object) -> str:
    """The SVG element of a panel; in a document of its own at a `place` (x, y, width, height)
    there.
    """
    frame, pen = panel.frame, _Pen(panel.frame, alone)
    left, top, right, bottom = frame.box
    area = {"x": left, "y": top, "width": right - left, "height": bottom - top}
    marks = _element(
        "g",
        "".join(pen.draw(mark) for mark in panel.marks) or " ",
        **({} if alone else {"class_": "marks"}),
    )
    parts = [marks]
    if not panel.bare:
        corner = f"M{left:g} {top:g}L{left:g} {bottom:g}L{right:g} {bottom:g}"
        parts = [
            _element("clipPath", _element("rect", **area), id=f"clip-{panel.name}"),
            _element("rect", **area, **pen.look("area")),
            pen.axes(panel.x, panel.y),
            _element("g", marks, clip_path=f"url(#clip-{panel.name})"),
            _element("path", d=corner, **pen.look("axis")),
        ]
    lines = [(panel.title, "title")] if panel.title else []
    lines += [(note, "measure") for note in panel.notes]
    first = top - 9.0 - _LINE * (len(lines) - 1)
    parts += [
        pen.words(left if css == "title" else 24.0, first + _LINE * k, text, css)
        for k, (text, css) in enumerate(lines)
    ]
    box = {"viewBox": f"0 0 {frame.width:g} {frame.height:g}"}
    if alone:
        return _element("svg", "".join(parts), **box, **place)
    custom = " ".join(f"{number:g}={text}" for number, text in panel.x.ticks)
    scales = (
        {} if panel.bare and not panel.css else {"data_x": frame.x.words, "data_y": frame.y.words}
    )
    names = {
        "data_x_words": panel.x.words,
        "data_y_words": panel.y.words,
        "data_time": panel.time,
        "data_x_ticks": custom,
    }
    names |= (
        {"data_counts": f"{panel.x.count} {panel.y.count}"}
        if (panel.x.count, panel.y.count) != (5, 5)
        else {}
    )
    kind = (
        "sketch"
        if panel.bare and not panel.css
        else " ".join(["panel", *panel.css.split(), *["equal"] * panel.equal])
    )
    return _element(
        "svg",
        "".join(parts),
        **box,
        role="img",
        aria_label=panel.alt,
        class_=kind,
        id=f"panel-{panel.name}",
        **scales,
        **names,
    )
