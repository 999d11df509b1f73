"""A figure as a value: axes and marks in their units, panels, the key to its lines, its words and
numbers; and its form as SVG.

On a page the style sheet colours a panel, so that it follows dark mode and print; an SVG file
carries its own colours. Words are escaped in `_element` and `_Pen.text_element` and nowhere else.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.charts.templating import (
    STATE_NAMES,
    Table,
    colours_of,
    parts_with_subscripts,
    style_of,
    table_text,
    template,
)
from scenes.array_types import Array

# --------------------------------------------------------------------------------- places and ticks


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

    def pixels_of(self, values: ArrayLike) -> Array:
        """Places of `values` along the axis [pixels]. NaN for NaN, and on a logarithmic axis for
        values that are not positive.

        The axis shows the numbers from `low` to `high`, at the places from `start` to `end`; `log`
        says whether it is logarithmic.

        >>> (
        ...     Scale(0.0, 2.0, 0.0, 100.0).pixels_of([0.5]),
        ...     Scale(1.0, 100.0, 0.0, 1.0, log=True).pixels_of([10.0]),
        ... )
        (array([25.]), array([0.5]))
        """
        numbers = np.asarray(values, dtype=float)
        low_end = self.low
        high_end = self.high
        if self.log:
            numbers = np.log10(np.where(numbers > 0, numbers, np.nan))
            low_end = float(np.log10(low_end))
            high_end = float(np.log10(high_end))
        fraction_of_axis = (numbers - low_end) / (high_end - low_end)
        return np.asarray(self.start + fraction_of_axis * (self.end - self.start))

    @property
    def words(self) -> str:
        """For a script: low, high, start, end, and whether it is logarithmic."""
        return f"{self.low:.9g} {self.high:.9g} {self.start:.6g} {self.end:.6g} {int(self.log)}"


def _ticks(
    lower_end: float, upper_end: float, n_ticks: int = 5, *, log: bool = False
) -> list[float]:
    """Round numbers between `lower_end` and `upper_end` of an axis, about `n_ticks` of them, for
    its ticks. On a logarithmic axis powers of ten, and 1, 2, 5 where it is short.

    >>> _ticks(-1.2, 1.2), _ticks(1e-4, 1.0, log=True), _ticks(0.9, 9.0, log=True)
    ([-1.0, -0.5, 0.0, 0.5, 1.0], [0.0001, 0.001, 0.01, 0.1, 1.0], [1.0, 2.0, 5.0])
    >>> _ticks(-17.0, 17.0, 3)
    [-10.0, 0.0, 10.0]
    """
    if log:
        numbers = _ticks_of_powers(lower_end, upper_end, n_ticks)
    else:
        numbers = _even_ticks(lower_end, upper_end, n_ticks)
    return [float(f"{number:.12g}") + 0.0 for number in numbers]


def _ticks_of_powers(lower_end: float, upper_end: float, n_ticks: int) -> list[float]:
    """Ticks of a logarithmic axis from `lower_end` to `upper_end`: powers of ten, at most about
    `n_ticks` of them; where there are fewer than three, with two and five times them.
    """
    first_exponent = np.ceil(np.log10(lower_end) - 1e-9)
    last_exponent = np.floor(np.log10(upper_end) + 1e-9)
    exponents = np.arange(first_exponent, last_exponent + 1)
    if len(exponents) >= 3:
        stride = -(-len(exponents) // (n_ticks + 1))
        return [10.0**exponent for exponent in exponents[::stride]]
    exponents = np.arange(np.floor(np.log10(lower_end)), np.ceil(np.log10(upper_end)) + 1)
    numbers = [digit * 10.0**exponent for exponent in exponents for digit in (1, 2, 5)]
    return [tick for tick in numbers if lower_end * (1 - 1e-9) <= tick <= upper_end * (1 + 1e-9)]


def _even_ticks(lower_end: float, upper_end: float, n_ticks: int) -> list[float]:
    """Round numbers from `lower_end` to `upper_end` for the ticks of an axis, about `n_ticks` of
    them: multiples of 1, 2, 2.5 or 5 times a power of ten.
    """
    # the least round distance of ticks that gives no more than about `n_ticks`
    rough_step = (upper_end - lower_end) / n_ticks
    power_of_ten = 10.0 ** np.floor(np.log10(rough_step))
    steps = [factor * power_of_ten for factor in (1, 2, 2.5, 5, 10)]
    step_index = next(index for index, step in enumerate(steps) if step >= 0.999 * rough_step)
    ticks = _multiples(lower_end, upper_end, steps[step_index])
    # One number says nothing of an axis' scale: then the next finer step, which is below
    # `rough_step` and has more than one.
    if len(ticks) <= 1 and step_index > 0:
        ticks = _multiples(lower_end, upper_end, steps[step_index - 1])
    return ticks.tolist()


def _multiples(lower_end: float, upper_end: float, step: float) -> Array:
    """The multiples of a step from `lower_end` to `upper_end`, (n,)."""
    first_multiple = np.ceil(lower_end / step - 1e-9)
    last_multiple = np.floor(upper_end / step + 1e-9)
    return np.asarray(np.arange(first_multiple, last_multiple + 1) * step)


def tick_labels(numbers: Sequence[float]) -> list[str]:
    """Texts of numbers beside an axis, with a real minus sign.

    >>> tick_labels([-0.5, 0.0, 0.5]), tick_labels([0.0, 20000.0]), tick_labels([1e-06, 2e-06])
    (['−0.5', '0', '0.5'], ['0', '20000'], ['1e−6', '2e−6'])
    """
    return [_label(number) for number in numbers]


def _label(number: float) -> str:
    """A number beside an axis: six digits, a real minus sign, a short exponent."""
    text = f"{number:.6g}"
    if 0 < abs(number) < 1e-3:
        text = np.format_float_scientific(number, precision=5, trim="-")
    if "e" in text:
        mantissa, exponent = text.split("e")
        text = f"{mantissa}e{int(exponent)}"
    return text.replace("-", "−")


def axis_limits(
    *values: ArrayLike, margin: float = 0.06, least_range: float = 0.0, with_zero: bool = False
) -> tuple[float, float]:
    """Lower and upper end of an axis for these arrays of values: the range of those that are
    finite, 0 to 1 without any, with a margin on both sides. The range is never empty.

    Parameters
    ----------
    margin
        on each side, as a fraction of the range
    least_range
        smallest range, in the unit of the values
    with_zero
        whether the range must hold 0
    """
    # least and largest of all values
    numbers = np.concatenate([np.ravel(np.asarray(array, dtype=float)) for array in values])
    finite_numbers = numbers[np.isfinite(numbers)]
    lower_end = float(finite_numbers.min()) if finite_numbers.size else 0.0
    upper_end = float(finite_numbers.max()) if finite_numbers.size else 1.0
    if with_zero:
        lower_end = min(lower_end, 0.0)
        upper_end = max(upper_end, 0.0)

    # widen a range that is too small, about its middle: to 1e-9 of the values at least
    largest_size = max(abs(lower_end), abs(upper_end))
    shown_range = max(upper_end - lower_end, least_range, 1e-9 * largest_size, 1e-300)
    if upper_end - lower_end < shown_range:
        middle = (lower_end + upper_end) / 2
        lower_end = middle - shown_range / 2
        upper_end = middle + shown_range / 2
    return lower_end - margin * shown_range, upper_end + margin * shown_range


@dataclass(frozen=True)
class Axis:
    """What an axis shows: from `low` to `high`, its words, whether it is logarithmic, about how
    many ticks (0: none), or which.
    """

    low: float
    high: float
    words: str
    log: bool = False
    n_ticks: int = 5
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
    is_closed: bool = False  # joined to its start, for outlines and filled shapes


@dataclass(frozen=True, eq=False)
class Band:
    """The area between two curves; a NaN leaves a gap."""

    x: ArrayLike
    low: ArrayLike
    high: ArrayLike
    css: str
    label: str = ""


# Segments that a page holds once are rounded to whole multiples of it, in numbers of the axes.
_GRAIN = 2e-4


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines: `end_points` (n, 2, 2) holds for each line its two ends, each as x and y.

    On a page several panels can show the same lines, which it then holds once, rounded to whole
    multiples of `_GRAIN`. All these panels have their `name`, all but the first `is_repeated`.
    """

    end_points: NDArray[np.float64]
    css: str
    name: str = ""
    is_repeated: bool = False


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
    """A line across the whole area: at x = `value` if upright, else at y = `value`."""

    value: float
    css: str
    is_upright: bool = False


@dataclass(frozen=True)
class Block:
    """A rectangle between two x and two y; `fill` where its colour stands for a number;
    `is_hatched` for what is not resolved.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    css: str = ""
    label: str = ""
    fill: str = ""
    is_hatched: bool = False


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
_ROOM_LEFT = 72.0
ROOM_RIGHT = 20.0
_ROOM_ABOVE = 12.0
_ROOM_BELOW = 46.0
_ROOM_BELOW_WITHOUT_WORDS = 24.0
_LINE_HEIGHT = 15.0  # height of a line of words
_UNIT_SCALE = Scale(0.0, 1.0, 0.0, 1.0)
# Of a line of more places only those that show stay: in each strip so wide the first, the last, the
# highest and the lowest.
_LONGEST_LINE_DRAWN_WHOLE = 2000
_WIDTH_OF_STRIP = 1.0
SUBSCRIPT_DROP = "3.5"  # how far a subscript stands below its line [units of a drawing]
_HATCH_DISTANCE = 7.0  # distance of the lines of a hatched block [units of a drawing]


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
    has_equal_scales: bool = False
    without_axes: bool = False  # no axes at all
    # left, top, right, bottom of it beside the area, automatic if None
    room: tuple[float, float, float, float] | None = None

    @property
    def frame(self) -> Frame:
        """The area of the panel in which curves and dots are drawn: the scales of both axes, which
        turn numbers into places of the drawing, and the size of the drawing.

        Around the area there is room for words and numbers. On a panel with `has_equal_scales` a
        unit of x is as long as a unit of y: one axis then shows more than it was given (`low`,
        `high`), on both sides. In the drawing y counts downwards.
        """
        # room beside the area: that of the panel, or as its words need it
        room_left, room_above, room_right, room_below = self.room or self._automatic_room()
        low_x = self.x.low
        high_x = self.x.high
        low_y = self.y.low
        high_y = self.y.high
        if self.has_equal_scales:
            area_width = self.width - room_left - room_right
            area_height = self.height - room_above - room_below
            units_per_pixel = max((high_x - low_x) / area_width, (high_y - low_y) / area_height)
            low_x, high_x = _about_the_middle(low_x, high_x, units_per_pixel * area_width)
            low_y, high_y = _about_the_middle(low_y, high_y, units_per_pixel * area_height)
        # ends in numbers, then in places of the drawing
        # Scale: ends of an axis, their places in the drawing, whether it is logarithmic
        x_scale = Scale(low_x, high_x, room_left, self.width - room_right, self.x.log)
        y_scale = Scale(low_y, high_y, self.height - room_below, room_above, self.y.log)
        return Frame(x_scale, y_scale, self.width, self.height)

    def _automatic_room(self) -> tuple[float, float, float, float]:
        """Room left of the area of curves, above, right of and below it, for the title, the notes
        and the words of axes.
        """
        lines_above = len(self.notes) + bool(self.title)
        bottom = _ROOM_BELOW if self.x.words else _ROOM_BELOW_WITHOUT_WORDS
        return _ROOM_LEFT, _ROOM_ABOVE + _LINE_HEIGHT * lines_above, ROOM_RIGHT, bottom

    def __html__(self) -> str:
        """The panel on a page."""
        return _panel_svg(self)


def _about_the_middle(lower_end: float, upper_end: float, size: float) -> tuple[float, float]:
    """Both ends of an interval of that size, about the middle of the one from `lower_end` to
    `upper_end`.
    """
    return (lower_end + upper_end - size) / 2, (lower_end + upper_end + size) / 2


@dataclass(frozen=True, eq=False)
class Cell:
    """Panels that belong together, one under the other; where it has an `event_instant`, a click
    shows that instant of the cycle.
    """

    panels: tuple[Panel, ...]
    event_instant: int | None

    def __html__(self) -> str:
        """The panels of the cell as HTML, one under the other; with the instant that a click on it
        shows.
        """
        content = "".join(panel.__html__() for panel in self.panels)
        if self.event_instant is None:
            return f"<div>{content}</div>"
        return f'<div class="cell" data-event="{self.event_instant:d}">{content}</div>'


@dataclass(frozen=True)
class Key:
    """An entry of a legend: the look of its lines or patches, and what they stand for."""

    css: str
    text: str
    is_patch: bool = False


STATE_KEYS = tuple(
    Key(f"state-{int(state)}", name, is_patch=True) for state, name in STATE_NAMES.items()
)


@dataclass(frozen=True, eq=False)
class Plate:
    """A figure."""

    name: str  # stem of its files
    # title, caption: for the page
    title: str
    caption: str
    alt: str  # what it shows, for who can't see it
    panels: tuple[Panel | Cell, ...]  # set side by side where there is room, at most `n_columns`
    table: Table  # column heading (with unit) -> values, all of one length; what the figure draws
    keys: tuple[Key, ...] = ()  # the legend, above the panels
    n_columns: int = 2

    def svg(self) -> str:
        """The whole figure as the text of an SVG document that needs no style sheet: its legend,
        and beneath it its panels in columns.

        Panels that belong together form a stack, one under the other. Stacks fill the columns
        (at most `self.n_columns`) row by row; a row is as high as its highest stack.
        """
        # tuples of panels, by column; a column is as wide as its widest stack [units of a drawing]
        panel_stacks = panel_stacks_of(self)
        n_columns = min(self.n_columns, len(panel_stacks))
        stacks_by_column = [panel_stacks[column::n_columns] for column in range(n_columns)]
        widths = [_width_of_stacks(stacks_of_column) for stacks_of_column in stacks_by_column]
        width = sum(widths)

        # the legend, then row by row each stack from its top to its bottom
        elements, top_of_row = self._legend(width)
        for first_index in range(0, len(panel_stacks), n_columns):
            stacks_of_row = panel_stacks[first_index : first_index + n_columns]
            bottom_of_row = top_of_row
            for column, stack in enumerate(stacks_of_row):
                top_of_panel = top_of_row
                for panel in stack:
                    place_and_size = {
                        "x": sum(widths[:column]),
                        "y": top_of_panel,
                        "width": panel.width,
                        "height": panel.height,
                    }
                    elements.append(_panel_svg(panel, is_standalone=True, **place_and_size))
                    top_of_panel += panel.height
                bottom_of_row = max(bottom_of_row, top_of_panel)
            top_of_row = bottom_of_row

        background = _element("rect", width=width, height=top_of_row, fill="#ffffff")
        return _element(
            "svg",
            f"<title>{escape(self.title)}</title>{background}{''.join(elements)}",
            xmlns="http://www.w3.org/2000/svg",
            width=f"{width:g}",
            height=f"{top_of_row:g}",
            viewBox=f"0 0 {width:g} {top_of_row:g}",
            font_family="DejaVu Sans, Segoe UI, sans-serif",
            font_size="12",
        )

    def _legend(self, width: float) -> tuple[list[str], float]:
        """SVG elements of the legend, in rows no wider than `width` [pixels], and the height that
        they take, 0 without a legend. An entry (`self.keys`) is a short line or a patch in the look
        of its class in the style sheet (`css`), and its text.
        """
        # the pen makes SVG elements, which carry their look themselves
        # _UNIT_SCALE: from 0 to 1, for a pen without axes
        pen = _Pen(Frame(_UNIT_SCALE, _UNIT_SCALE, 0, 0), is_standalone=True)
        x_of_entry = 10.0
        y_of_entry = 6.0
        elements = []
        for key in self.keys:
            width_of_entry = 44.0 + 6.6 * len(key.text)  # letters 12 high are 6.6 wide in the mean
            if x_of_entry > 10.0 and x_of_entry + width_of_entry > width:
                x_of_entry = 10.0
                y_of_entry += 18.0
            if key.is_patch:
                look = pen.look_attributes(f"{key.css} patch")
                elements.append(
                    _element(
                        "rect", x=x_of_entry + 4, y=y_of_entry + 2, width=16, height=10, **look
                    )
                )
            else:
                path = f"M{x_of_entry:g} {y_of_entry + 7:g}L{x_of_entry + 24:g} {y_of_entry + 7:g}"
                elements.append(_element("path", d=path, **pen.look_attributes(f"curve {key.css}")))
            elements.append(pen.text_element(x_of_entry + 30, y_of_entry + 11, key.text, "word"))
            x_of_entry += width_of_entry
        return elements, y_of_entry + 22.0 if self.keys else 0.0

    def csv(self) -> str:
        """The table, numbers to the last digit; an empty cell stands for "no such thing"."""
        return table_text(self.table)

    def __html__(self) -> str:
        """The figure on a page: legend, panels, caption."""
        return str(template("figure.html").module.drawn(self))  # type: ignore[attr-defined]


def figure_with_texts(
    name: str,
    panels: Sequence[Panel | Cell],
    table: Table,
    keys: Sequence[Key] = (),
    *,
    n_columns: int = 2,
    words: str = "",
    **caption_values: object,
) -> Plate:
    """A figure of a page, with title, caption and description (for readers who can't see it) taken
    from templates/figures.txt.

    TypeError for a value that these texts have no place for, and UndefinedError where one is
    missing that they need.

    Parameters
    ----------
    name
        of the figure, and of its CSV file
    table
        values drawn, by column, for the CSV file
    keys
        entries of the legend
    n_columns
        how many panels stand side by side
    words
        name of the macro in templates/figures.txt that has the texts; `name` by default
    caption_values
        numbers, words and truth values that the texts need, by the names they have there
    """
    # three lines: title, caption, description
    texts = getattr(template("figures.txt").module, words or name)(**caption_values)
    title, caption, description = str(texts).strip().split("\n")
    # Plate: a figure with its texts, panels, CSV table and legend
    return Plate(name, title, caption, description, tuple(panels), table, tuple(keys), n_columns)


def _width_of_stacks(column: Sequence[tuple[Panel, ...]]) -> float:
    """The width that stacks of panels need in one column: the largest of their first panels."""
    return max(stack[0].width for stack in column)


def panel_stacks_of(plate: Plate) -> list[tuple[Panel, ...]]:
    """The panels of a figure as stacks, which are drawn one under the other: those of a cell
    together, each other panel alone.
    """
    return [part.panels if isinstance(part, Cell) else (part,) for part in plate.panels]


def colour_scale(
    name: str,
    ends: tuple[float, float],
    words: str,
    colours: str = "viridis",
    *,
    log: bool = False,
    tick_values: Sequence[float] = (),
    width: float = 480.0,
) -> Panel:
    """A panel that shows what the colours of a map stand for: a strip of colours with numbers.

    Parameters
    ----------
    name
        of the panel
    ends
        values at the lower and the upper end of the strip
    words
        the quantity, with its unit, for the axis
    colours
        name of the colour map
    log
        whether the axis is logarithmic
    tick_values
        numbers beside the axis, of which those between the ends are shown; round numbers by default
    width
        of the panel [pixels]
    """
    # ends that differ, and ticks between them
    low_end, high_end = ends
    if high_end <= low_end:
        high_end = low_end + (abs(low_end) or 1.0)
    tick_numbers = [value for value in tick_values if low_end <= value <= high_end]
    if not tick_values:
        tick_numbers = _ticks(low_end, high_end, 4, log=log)

    # one row of 64 pixels, each of its own colour
    fractions_of_axis = (np.arange(64) + 0.5) / 64
    strip = Bitmap(np.arange(64, dtype=np.uint8)[None, :], colours_of(fractions_of_axis, colours))
    ticks = tuple(zip(tick_numbers, tick_labels(tick_numbers), strict=True))
    # Panel: name, both axes, marks, description, width and height
    return Panel(
        name,
        Axis(low_end, high_end, words, log, ticks=ticks),
        Axis(0.0, 1.0, "", n_ticks=0),
        [strip],
        f"Colours: {words}",
        width,
        74.0,
        css="colours",
    )


def _attributes(attributes: Mapping[str, object]) -> str:
    """Attributes of an XML element as text, each with a blank before it. "_" in a name is written
    as "-". Attributes that are None or empty are left out, numbers have two decimals at most.

    >>> _attributes({"data_label": 'a "b"', "x": 1.5, "class_": ""})
    ' data-label="a &quot;b&quot;" x="1.5"'
    """
    attributes_text = ""
    for name, value in attributes.items():
        if value is not None and value != "":
            value_text = str(value)
            if isinstance(value, float):
                value_text = f"{value:.2f}".rstrip("0").rstrip(".")
            attributes_text += f' {name.rstrip("_").replace("_", "-")}="{escape(value_text)}"'
    return attributes_text


def _element(name: str, content: str = "", /, **attributes: object) -> str:
    """The text of an SVG element with its attributes; `content` is SVG already. "" where an
    attribute is no finite number, so that nothing is drawn.
    """
    if any(isinstance(value, float) and not math.isfinite(value) for value in attributes.values()):
        return ""
    start = f"{name}{_attributes(attributes)}"
    return f"<{start}>{content}</{name}>" if content else f"<{start}/>"


def _path_data(
    horizontal_places: ArrayLike,
    vertical_places: ArrayLike,
    tolerance: float = 0.0,
    passes: int = 0,
) -> str:
    """The "d" attribute of an SVG path: a line through points given by their horizontal and
    vertical places [pixels]. A NaN breaks the line into several.

    Points that repeat the one before to a hundredth are left out; of a line of more than 2000
    points (`_LONGEST_LINE_DRAWN_WHOLE`) so are those that can't be seen. Then points are left out
    that lie within `tolerance` [pixels] of the chord between their neighbours. One pass looks at
    every other point; there are `passes`.

    >>> (
    ...     _path_data([0, 1, np.nan, 2, 3], [0, 1, 1, 1, 1]),
    ...     _path_data([0, 1, 2, 3, 4], [0, 0, 0, 0, 5], 0.1, 2),
    ... )
    ('M0 0L1 1M2 1L3 1', 'M0 0L3 0L4 5')

    A point without neighbours becomes a line to itself, which is drawn as a dot. So does a point
    that is only repeated.

    >>> _path_data([0, np.nan, 2, 2], [0, 1, 1, 1])
    'M0 0L0 0M2 1L2 1'
    """
    points = _points_that_show(
        np.round(np.asarray(horizontal_places, dtype=float), 2),
        np.round(np.asarray(vertical_places, dtype=float), 2),
    )
    # leave out points on the chord between their neighbours
    for _ in range(passes):
        is_on_chord = _is_on_chord(points.x, points.y, points.is_first, tolerance)
        points = points.at(~is_on_chord)
    is_last = np.append(points.is_first[1:], True)

    # as Python's numbers, which are formatted in half the time of numpy's
    numbers = zip(
        points.x.tolist(),
        points.y.tolist(),
        points.is_first.tolist(),
        (points.is_first & is_last).tolist(),
        strict=True,
    )
    path = []
    for point_x, point_y, begins_line, has_no_neighbour in numbers:
        coordinates = f"{point_x:g} {point_y:g}"
        path.append(f"M{coordinates}" if begins_line else f"L{coordinates}")
        if has_no_neighbour:
            path.append(f"L{coordinates}")
    return "".join(path)


class _LinePoints(NamedTuple):
    """Points of one or several lines in a drawing, (n,) each."""

    x: Array  # horizontal places [pixels]
    y: Array  # vertical places [pixels]
    is_first: NDArray[np.bool_]  # whether a line begins at the point

    def at(self, selection: NDArray[np.bool_]) -> _LinePoints:
        """The points for which `selection` (n,) is True."""
        return _LinePoints(self.x[selection], self.y[selection], self.is_first[selection])


def _points_that_show(x: Array, y: Array) -> _LinePoints:
    """The points of a line that show when it is drawn. Left out are points that repeat the one
    before and, of more than 2000 points, those that can't be seen.

    `x`, `y` are places (n,), rounded [pixels]; a NaN in either breaks the line into several.
    """
    is_known = np.isfinite(x) & np.isfinite(y)
    if len(x) > _LONGEST_LINE_DRAWN_WHOLE:
        visible_indices = _visible_indices(x, y, is_known)
        x = x[visible_indices]
        y = y[visible_indices]
        is_known = is_known[visible_indices]
    has_moved = np.ones(len(x), dtype=bool)
    has_moved[1:] = (x[1:] != x[:-1]) | (y[1:] != y[:-1]) | ~is_known[:-1]
    is_first = is_known & ~np.concatenate([[False], is_known[:-1]])  # of a line
    return _LinePoints(x, y, is_first).at(is_known & has_moved)


def _is_on_chord(
    x: Array, y: Array, is_first: NDArray[np.bool_], tolerance: float
) -> NDArray[np.bool_]:
    """Whether each point of a line can be left out, (n,). The second, fourth, ... point can if it
    lies within `tolerance` [pixels] of the chord between its neighbours. False for all others.

    Parameters
    ----------
    x, y
        (n,) each, points in the order of the line [pixels]
    is_first
        (n,) True where another line begins: neither this point nor the one before is left out
    """
    # indices of the points that are looked at (`middle_points`), and of their neighbours
    points_before = slice(0, len(x) - 2, 2)
    middle_points = slice(1, len(x) - 1, 2)
    points_after = slice(2, None, 2)
    chord_x = x[points_after] - x[points_before]
    chord_y = y[points_after] - y[points_before]
    x_of_middle = x[middle_points] - x[points_before]
    y_of_middle = y[middle_points] - y[points_before]
    # twice the area of the triangle is its height times its base, the chord
    twice_the_area = np.abs(chord_x * y_of_middle - chord_y * x_of_middle)
    is_near = twice_the_area <= tolerance * np.hypot(chord_x, chord_y)
    is_on_chord = np.zeros(len(x), dtype=bool)
    is_on_chord[middle_points] = is_near & ~is_first[middle_points] & ~is_first[points_after]
    return is_on_chord


def _visible_indices(x: Array, y: Array, is_known: NDArray[np.bool_]) -> NDArray[np.int_]:
    """Indices of those points of a long line through (x, y) that can be seen when it is drawn.

    The drawing is cut into upright strips one pixel wide (`_WIDTH_OF_STRIP`). A visit is a run of
    points that follow each other within one strip. Of each visit the first, the last, the highest
    and the lowest point are kept.

    Parameters
    ----------
    x, y
        (n,) each [pixels]
    is_known
        (n,) False where the line is broken
    """
    # Numbers of strip and visit of each point, (n,). NaN is unequal to itself: each point where the
    # line is broken is a visit of its own.
    strip_number = np.where(is_known, np.floor(x / _WIDTH_OF_STRIP), np.nan)
    visit_number = np.concatenate([[0], np.cumsum(strip_number[1:] != strip_number[:-1])])

    # indices of the points visit by visit, those of each in the order of y
    sorted_by_y = np.lexsort((np.where(is_known, y, 0.0), visit_number))
    # of each visit the first and last index, in either order of the points
    first_index = np.flatnonzero(np.diff(visit_number, prepend=-1))
    last_index = np.append(first_index[1:], len(visit_number)) - 1
    return np.unique(
        np.concatenate([first_index, last_index, sorted_by_y[first_index], sorted_by_y[last_index]])
    )


def _png(
    pixels: NDArray[np.uint8], colours: Sequence[str] = (), *, all_colours: bool = False
) -> bytes:
    """A picture as the bytes of a PNG file. `pixels` are indices into `colours` (#rrggbb each), (n,
    m), or without `colours` red, green and blue of each pixel, (n, m, 3). These are reduced to 255
    different colours by median cut unless `all_colours`.

    >>> _png(np.zeros((1, 1), np.uint8), ["#ffffff"])[:8]
    b'\\x89PNG\\r\\n\\x1a\\n'
    """
    from PIL import Image

    picture = Image.fromarray(pixels)
    stream = io.BytesIO()
    if colours:
        picture.putpalette(b"".join(bytes.fromhex(colour.removeprefix("#")) for colour in colours))
    elif not all_colours:
        picture = picture.quantize(255)
    # An indexed picture of few colours is small as it is; one of 255 is worth a longer compression.
    picture.save(stream, "PNG", optimize=not colours and not all_colours)
    return stream.getvalue()


def _path_in_grains(end_points: NDArray[np.float64]) -> str:
    """The "d" attribute of an SVG path of straight lines, in whole multiples of a small length
    (`_GRAIN`, 2e-4 in numbers of the axes): each line as its start and the move to its end.
    `end_points` (n, 2, 2) are the two ends of each line, x and y each.
    """
    grains = np.rint(end_points / _GRAIN).astype(int)
    starts = grains[:, 0].tolist()
    moves = (grains[:, 1] - grains[:, 0]).tolist()
    lines = [
        f"M{start_x} {start_y}l{move_x} {move_y}"
        for (start_x, start_y), (move_x, move_y) in zip(starts, moves, strict=True)
    ]
    return "".join(lines)


def _path_of_hatching(left_x: float, right_x: float, least_y: float, largest_y: float) -> str:
    """The "d" attribute of an SVG path of oblique lines across a rectangle, given by its ends in
    the drawing [pixels]. "" where it is so small that no line crosses it.

    Along each line x + y is constant, a multiple of the distance of the lines (`_HATCH_DISTANCE`).
    The rectangle goes from `left_x` to `right_x` and from `least_y` to `largest_y`; y counts
    downwards.
    """
    first_line = np.ceil((left_x + least_y) / _HATCH_DISTANCE)
    last_line = np.floor((right_x + largest_y) / _HATCH_DISTANCE)
    sums_of_lines = np.arange(first_line, last_line + 1) * _HATCH_DISTANCE
    # the x at which each line enters and leaves the rectangle
    starts_x = np.maximum(left_x, sums_of_lines - largest_y)
    ends_x = np.minimum(right_x, sums_of_lines - least_y)
    path = ""
    for start_x, end_x, sum_of_line in zip(
        starts_x.tolist(), ends_x.tolist(), sums_of_lines.tolist(), strict=True
    ):
        if end_x > start_x:
            start_y = sum_of_line - start_x
            end_y = sum_of_line - end_x
            path += f"M{start_x:.1f} {start_y:.1f}L{end_x:.1f} {end_y:.1f}"
    return path


@dataclass(frozen=True)
class _Pen:
    """Draws marks in the frame of a panel as SVG."""

    frame: Frame
    is_standalone: bool  # True: in an SVG file without style sheet; False: on a page

    def look_attributes(self, css: str, *, text: bool = False) -> dict[str, object]:
        """The attributes that give an SVG element the look of the classes `css` in the style sheet.
        On a page they are the class names, in an SVG file of its own (`is_standalone`) the
        declarations of these classes. `text` says whether the element is a text.
        """
        if not self.is_standalone:
            return {"class_": css}
        declarations = [
            f"{name}:{value}"
            for name, value in style_of(css, text=text).items()
            if name not in ("vector-effect", "cursor")
        ]
        return {"style": ";".join(declarations)}

    def text_element(self, x: float, y: float, text: str, css: str, /, **attributes: object) -> str:
        """The SVG element of a text at (x, y) of the drawing; in "p_ref" the letters "ref" become a
        subscript. `css` names its classes in the style sheet; `attributes` are further ones of the
        element.
        """
        # each subscript, and the text behind it, is shifted (SUBSCRIPT_DROP: units of the drawing)
        content_of_element = ""
        was_subscript = False
        for part, is_subscript in parts_with_subscripts(text):
            shift: dict[str, object] = {}  # down to a subscript, and up again behind it
            if is_subscript is not was_subscript:
                shift = {"dy": SUBSCRIPT_DROP if is_subscript else f"-{SUBSCRIPT_DROP}"}
            look_of_subscript = self.look_attributes("sub") if is_subscript else {}
            escaped_part = escape(part)
            if shift or look_of_subscript:
                content_of_element += _element("tspan", escaped_part, **shift, **look_of_subscript)
            else:
                content_of_element += escaped_part
            was_subscript = is_subscript
        look = self.look_attributes(css, text=True)
        return _element("text", content_of_element, x=float(x), y=float(y), **look, **attributes)

    def data_attributes(self, attributes: Mapping[str, object]) -> dict[str, object]:
        """Attributes of an SVG element for the page's script, their names with "data_" before them;
        none in an SVG file of its own.
        """
        return (
            {}
            if self.is_standalone
            else {f"data_{name}": value for name, value in attributes.items()}
        )

    def draw(self, mark: Mark) -> str:
        """The SVG element of one mark in a panel: a curve, band, dot, rule (a line across the whole
        area), block, bitmap, text, arrow, or a group of these. All have the look of their classes
        in the style sheet (`css`); a `label` is what a pointer shows.
        """
        match mark:
            case Curve():
                return self.curve(mark)
            case Band():
                return self.band(mark)
            case Segments():
                return self.segments(mark)
            case Dot():
                return self.dot(mark)
            case Rule():
                return self.rule(mark)
            case Block():
                return self.block(mark)
            case Bitmap():
                return self.bitmap(mark)
            case Note():
                return self.note(mark)
            case Arrow():
                return self.arrow(mark)
            case Group():
                return self.group(mark)

    def dot(self, mark: Dot) -> str:
        """The SVG element of a round mark; its `x` and `y` are in numbers of the axes. `fill` is a
        colour that stands for a number, `label` the text that a pointer shows, `data` holds further
        values for the page's script.
        """
        attributes: dict[str, object] = {"fill": mark.fill or None}
        # `data_attributes`: for the page's script; none in an SVG file of its own
        attributes |= self.data_attributes({"label": mark.label} | dict(mark.data))
        return _element(
            "circle",
            cx=float(self.frame.x.pixels_of(mark.x)),
            cy=float(self.frame.y.pixels_of(mark.y)),
            r=mark.radius,
            **self.look_attributes(mark.css),
            **attributes,
        )

    def rule(self, mark: Rule) -> str:
        """The SVG element of a line across the whole area of a panel, at x = `value` of the mark if
        it `is_upright`, else at y = `value`, in numbers of the axes.
        """
        left_x, top_y, right_x, bottom_y = self.frame.box
        if mark.is_upright:
            place = float(self.frame.x.pixels_of(mark.value))
            ends = {"x1": place, "x2": place, "y1": top_y, "y2": bottom_y}
        else:
            place = float(self.frame.y.pixels_of(mark.value))
            ends = {"x1": left_x, "x2": right_x, "y1": place, "y2": place}
        return _element("line", **ends, **self.look_attributes(mark.css))

    def bitmap(self, mark: Bitmap) -> str:
        """The SVG element of a map that fills the area of a panel: a PNG picture, written into the
        element. In an SVG file of its own it keeps all its colours, on a page 255 of them at most.

        `mark.pixels` are indices into its `colours`, (n, m), or colours themselves, (n, m, 3).
        """
        left_x, top_y, right_x, bottom_y = self.frame.box
        png_bytes = _png(mark.pixels, mark.colours, all_colours=self.is_standalone)
        data_address = "data:image/png;base64," + base64.b64encode(png_bytes).decode()
        place_and_size = {
            "x": left_x,
            "y": top_y,
            "width": right_x - left_x,
            "height": bottom_y - top_y,
        }
        return _element(
            "image",
            **place_and_size,
            href=data_address,
            preserveAspectRatio="none",
            **self.look_attributes("map"),
        )

    def group(self, mark: Group) -> str:
        """The SVG element of marks that the page's script replaces together: their elements within
        one, which has the `data` of the mark for the script.
        """
        content = "".join(map(self.draw, mark.marks)) or " "
        return _element(
            "g",
            content,
            **self.look_attributes(mark.css),
            **self.data_attributes(mark.data),
        )

    def curve(self, mark: Curve) -> str:
        """The SVG element of a curve. On a page it keeps nearly all its points, which the pointer
        picks; in an SVG file of its own those on a straight line are left out.

        Of the mark, `x` and `y` are the curve's points in numbers of the axes, `css` its classes in
        the style sheet, `label` the text that a pointer shows, `data` further values for the page's
        script; `is_closed`: its end is joined to its start.
        """
        # `is_standalone`: for an SVG file of its own
        tolerance = 0.1 if self.is_standalone else 0.02  # [pixels]
        passes = 8 if self.is_standalone else 1
        # `frame` has the scales of both axes; `pixels_of`: places in the drawing
        x = self.frame.x.pixels_of(mark.x)
        y = self.frame.y.pixels_of(mark.y)
        # in each pass every other point within the tolerance of its neighbours' line is left out
        path = _path_data(x, y, tolerance, passes) or "M0 0"
        if mark.is_closed:
            path += "Z"
        attributes = self.data_attributes({"label": mark.label} | dict(mark.data))
        return _element("path", d=path, **self.look_attributes(f"curve {mark.css}"), **attributes)

    def band(self, mark: Band) -> str:
        """The SVG element of the area between a lower and an upper curve (`low` and `high` of the
        mark, over its `x`). Where either has a gap (NaN) one outline ends and another begins.
        """
        x = np.asarray(mark.x, dtype=float)
        lower_curve = np.asarray(mark.low, dtype=float)
        upper_curve = np.asarray(mark.high, dtype=float)

        # runs of indices: points without a gap between them, or a gap
        is_known = np.isfinite(lower_curve) & np.isfinite(upper_curve)
        path = ""
        for run in np.split(np.arange(len(is_known)), np.flatnonzero(np.diff(is_known)) + 1):
            if len(run) and is_known[run[0]]:
                # along the lower curve, and back along the upper one; in the drawing by `pixels_of`
                outline_x = np.concatenate([x[run], x[run][::-1]])
                outline_y = np.concatenate([lower_curve[run], upper_curve[run][::-1]])
                path += (
                    _path_data(self.frame.x.pixels_of(outline_x), self.frame.y.pixels_of(outline_y))
                    + "Z"
                )
        return _element("path", d=path or "M0 0", **self.look_attributes(f"band {mark.css}"))

    def note(self, mark: Note) -> str:
        """The SVG elements of a text at a place of the panel, one for each of its lines, one below
        the other.

        Of the mark, `x` and `y` are in numbers of the axes, `shift` moves the text (right, down) in
        units of the drawing, `anchor` says whether it starts, ends or has its middle there.
        """
        # `frame` has the scales of both axes; `pixels_of`: places in the drawing
        x = float(self.frame.x.pixels_of(mark.x))
        y = float(self.frame.y.pixels_of(mark.y))
        shift_right, shift_down = mark.shift
        attributes: dict[str, object] = {"dx": shift_right or None, "dy": shift_down or None}
        # `data_attributes`: for the page's script; none in an SVG file of its own
        attributes |= self.data_attributes(mark.data)
        anchor = None if mark.anchor == "start" else mark.anchor
        # _LINE_HEIGHT: 15 units of the drawing
        elements = [
            self.text_element(
                x, y + _LINE_HEIGHT * line_number, line, mark.css, text_anchor=anchor, **attributes
            )
            for line_number, line in enumerate(mark.text.split("\n"))
        ]
        return "".join(elements)

    def segments(self, mark: Segments) -> str:
        """The SVG element of many straight lines as one path, such as the lines of a mesh.

        On a page a path with a name is written once, in whole multiples of a small length
        (`_GRAIN`, 2e-4 in numbers of the axes). Other panels, where the mark is repeated, use it
        again at their own scale. A panel has one scale for x and y then, linear.

        Of the mark, `end_points` (n, 2, 2) are the two ends of each line, x and y each.
        """
        # written with its places in the drawing; `is_standalone`: for an SVG file of its own
        if self.is_standalone or not mark.name:
            return _element(
                "path",
                d=self.path_of_visible_lines(mark) or "M0 0",
                **self.look_attributes(mark.css),
            )

        # or in multiples of the small length, which a transform takes to places in the drawing
        if mark.is_repeated:
            content = _element("use", href=f"#{mark.name}")
        else:
            path = _path_in_grains(mark.end_points)
            content = _element("path", d=path, id=mark.name, **self.look_attributes(mark.css))
        return _element("g", content, transform=self.transform_of_grains())

    def transform_of_grains(self) -> str:
        """The "transform" attribute of an SVG element whose coordinates are whole multiples of a
        small length (`_GRAIN`, 2e-4 in numbers of the axes): it takes them to places in the
        drawing. The scale of x, which is linear, holds for y as well.
        """
        x_scale = self.frame.x
        pixels_per_unit = (x_scale.end - x_scale.start) / (x_scale.high - x_scale.low)
        pixels_per_grain = pixels_per_unit * _GRAIN
        x_of_origin = float(x_scale.pixels_of(0.0))
        y_of_origin = float(self.frame.y.pixels_of(0.0))
        return (
            f"translate({x_of_origin:.3f} {y_of_origin:.3f})"
            f" scale({pixels_per_grain:.7g} {-pixels_per_grain:.7g})"
        )

    def path_of_visible_lines(self, mark: Segments) -> str:
        """The "d" attribute of an SVG path of those straight lines that may reach into the panel's
        area: their bounding boxes do. `end_points` (n, 2, 2) of the mark are the two ends of each
        line, x and y each, in numbers of the axes.
        """
        # both ends of each line in the drawing (`pixels_of`), (n, 2); there y counts downwards
        x = self.frame.x.pixels_of(mark.end_points[..., 0])
        y = self.frame.y.pixels_of(mark.end_points[..., 1])
        is_visible = (x.max(axis=1) >= self.frame.x.start) & (x.min(axis=1) <= self.frame.x.end)
        is_visible &= (y.max(axis=1) >= self.frame.y.end) & (y.min(axis=1) <= self.frame.y.start)
        pairs_x = np.round(x[is_visible], 2).tolist()
        pairs_y = np.round(y[is_visible], 2).tolist()
        lines = [
            f"M{start_x:g} {start_y:g}L{end_x:g} {end_y:g}"
            for (start_x, end_x), (start_y, end_y) in zip(pairs_x, pairs_y, strict=True)
        ]
        return "".join(lines)

    def block(self, mark: Block) -> str:
        """The SVG elements of a rectangle given by its ends on both axes (`x` and `y` of the mark);
        where the mark `is_hatched`, oblique lines are drawn over it. `fill` is a colour that stands
        for a number, `label` the text that a pointer shows.
        """
        # in the drawing (`pixels_of`), where y counts downwards
        left_x, right_x = np.sort(self.frame.x.pixels_of(mark.x))
        least_y, largest_y = np.sort(self.frame.y.pixels_of(mark.y))
        place = {
            "x": float(left_x),
            "y": float(least_y),
            "width": float(right_x - left_x),
            "height": float(largest_y - least_y),
        }
        attributes = {"fill": mark.fill or None} | self.data_attributes({"label": mark.label})
        rectangle = _element("rect", **place, **self.look_attributes(mark.css), **attributes)
        hatching = ""
        if mark.is_hatched:
            hatching = _path_of_hatching(left_x, right_x, least_y, largest_y)
        if not hatching:
            return rectangle
        return rectangle + _element("path", d=hatching, **self.look_attributes("hatching"))

    def arrow(self, mark: Arrow) -> str:
        """The SVG elements of an arrow from `mark.start` to `mark.end` (x and y in numbers of the
        axes): its line, and a filled head whose tip lies at the end. Both have the look of the
        mark's classes in the style sheet (`css`).
        """
        # ends, and directions along the arrow and across it, in the drawing (`pixels_of`) [pixels]
        start_x, end_x = self.frame.x.pixels_of([mark.start[0], mark.end[0]])
        start_y, end_y = self.frame.y.pixels_of([mark.start[1], mark.end[1]])
        tip = np.array([end_x, end_y])
        vector_from_start = tip - np.array([start_x, start_y])
        direction = vector_from_start / np.hypot(*vector_from_start)
        normal_direction = np.array([-direction[1], direction[0]])

        # corners of the head, 11 pixels long and 9 wide; the line ends within it
        head = np.array(
            [
                tip,
                tip - 11 * direction + 4.5 * normal_direction,
                tip - 11 * direction - 4.5 * normal_direction,
            ]
        )
        end_of_line = tip - 9 * direction
        path = _path_data([start_x, end_of_line[0]], [start_y, end_of_line[1]])
        line = _element("path", d=path, **self.look_attributes(f"curve {mark.css}"))
        outline = _path_data(head[:, 0], head[:, 1]) + "Z"
        return line + _element("path", d=outline, **self.look_attributes(f"head {mark.css}"))

    def axes(self, x: Axis, y: Axis) -> str:
        """The SVG elements of the axes `x` and `y` of a panel: grid lines at the ticks, the numbers
        beside them, and the axis titles. A number or title for which there is no room below the
        area is left out.
        """
        elements = [*self.ticks_of_x(x), *self.ticks_of_y(y)]
        left_x, top_y, right_x, bottom_y = self.frame.box
        if x.words and self.frame.height - bottom_y > 30:
            middle_of_axis = (left_x + right_x) / 2
            elements.append(
                self.text_element(
                    middle_of_axis, bottom_y + 36, x.words, "name", text_anchor="middle"
                )
            )
        if y.words:
            middle_of_axis = (top_y + bottom_y) / 2
            rotation = f"rotate(-90 12 {middle_of_axis:g})"
            elements.append(
                self.text_element(
                    12, middle_of_axis, y.words, "name", text_anchor="middle", transform=rotation
                )
            )
        return "".join(elements)

    def ticks_of_x(self, axis: Axis) -> list[str]:
        """The SVG elements of the ticks of a level axis: at each an upright grid line, and its
        number below the area where there is room for it.
        """
        _, top_y, _, bottom_y = self.frame.box
        room_below = self.frame.height - bottom_y
        elements = []
        for number, text in _tick_pairs(axis, self.frame.x):
            place = float(self.frame.x.pixels_of(number))
            look_of_grid = self.look_attributes("grid across")
            elements.append(
                _element("line", x1=place, x2=place, y1=top_y, y2=bottom_y, **look_of_grid)
            )
            if room_below > 16:
                elements.append(
                    self.text_element(
                        place, bottom_y + 15, text, "tick across", text_anchor="middle"
                    )
                )
        return elements

    def ticks_of_y(self, axis: Axis) -> list[str]:
        """The SVG elements of the ticks of an upright axis: at each a level grid line, and its
        number left of the area.
        """
        left_x, _, right_x, _ = self.frame.box
        elements = []
        for number, text in _tick_pairs(axis, self.frame.y):
            place = float(self.frame.y.pixels_of(number))
            look_of_grid = self.look_attributes("grid upright")
            elements.append(
                _element("line", x1=left_x, x2=right_x, y1=place, y2=place, **look_of_grid)
            )
            elements.append(
                self.text_element(left_x - 6, place + 4, text, "tick upright", text_anchor="end")
            )
        return elements


def _tick_pairs(axis: Axis, scale: Scale) -> tuple[tuple[float, str], ...]:
    """Each tick of an axis with its text: the axis' own, or round numbers."""
    if axis.ticks or not axis.n_ticks:
        return axis.ticks
    numbers = _ticks(scale.low, scale.high, axis.n_ticks, log=axis.log)
    return tuple(zip(numbers, tick_labels(numbers), strict=True))


def _panel_svg(panel: Panel, *, is_standalone: bool = False, **place: object) -> str:
    """The SVG element of a panel: its marks, the lines of text above it and, unless it is
    `without_axes`, its area and axes.

    With `is_standalone` it is for an SVG file without style sheet, at `place` (x, y, width, height)
    in it; else for a page, with the attributes that the page's script reads.

    The area is the rectangle in which curves are drawn. Lines of text are the panel's title and its
    `notes`, which hold numbers.
    """
    frame = panel.frame  # the area, with the scales of both axes
    pen = _Pen(frame, is_standalone)  # makes SVG elements
    content_of_marks = "".join(map(pen.draw, panel.marks)) or " "
    # on a page the page's script finds them by their class
    drawn_marks = _element("g", content_of_marks, **({} if is_standalone else {"class_": "marks"}))
    elements = [drawn_marks] if panel.without_axes else _area_with_axes(panel, pen, drawn_marks)
    elements += _lines_above(panel, pen)

    # the element around all of them; `alt` describes the panel for readers who can't see it
    view_box = {"viewBox": f"0 0 {frame.width:g} {frame.height:g}"}
    if is_standalone:
        return _element("svg", "".join(elements), **view_box, **place)
    return _element(
        "svg",
        "".join(elements),
        **view_box,
        role="img",
        aria_label=panel.alt,
        class_=_classes_of(panel),
        id=f"panel-{panel.name}",
        **_script_attributes(panel, frame),
    )


def _area_with_axes(panel: Panel, pen: _Pen, drawn_marks: str) -> list[str]:
    """SVG elements of the area of a panel, the rectangle in which curves are drawn: its background,
    grid and axes, and the marks, cut off at its ends. `drawn_marks` is the SVG element of the
    marks.

    `pen` makes SVG elements in the scales of the panel.
    """
    left_x, top_y, right_x, bottom_y = pen.frame.box
    area = {"x": left_x, "y": top_y, "width": right_x - left_x, "height": bottom_y - top_y}
    corner = f"M{left_x:g} {top_y:g}L{left_x:g} {bottom_y:g}L{right_x:g} {bottom_y:g}"
    return [
        _element("clipPath", _element("rect", **area), id=f"clip-{panel.name}"),
        _element("rect", **area, **pen.look_attributes("area")),
        pen.axes(panel.x, panel.y),
        _element("g", drawn_marks, clip_path=f"url(#clip-{panel.name})"),
        _element("path", d=corner, **pen.look_attributes("axis")),
    ]


def _lines_above(panel: Panel, pen: _Pen) -> list[str]:
    """SVG elements of the lines of text above the area of a panel: its title, and its notes, which
    hold numbers. The last line stands 9 units of the drawing above the area.

    `pen` makes SVG elements in the scales of the panel.
    """
    left_x, top_y, _, _ = pen.frame.box
    # each with its x and its class in the style sheet
    lines_above = [(left_x, panel.title, "title")] if panel.title else []
    lines_above += [(24.0, note, "measure") for note in panel.notes]
    # _LINE_HEIGHT: 15 units of the drawing
    y_of_first_line = top_y - 9.0 - _LINE_HEIGHT * (len(lines_above) - 1)
    return [
        pen.text_element(x_of_line, y_of_first_line + _LINE_HEIGHT * line_number, text, css)
        for line_number, (x_of_line, text, css) in enumerate(lines_above)
    ]


def _is_sketch(panel: Panel) -> bool:
    """Whether a panel stands still: the page's script leaves it as it is."""
    return panel.without_axes and not panel.css


def _classes_of(panel: Panel) -> str:
    """The CSS classes of a panel on a page, as one text."""
    if _is_sketch(panel):
        return "sketch"
    class_names = ["panel", *panel.css.split()]
    if panel.has_equal_scales:
        class_names.append("equal")
    return " ".join(class_names)


def _script_attributes(panel: Panel, frame: Frame) -> dict[str, object]:
    """Attributes of a panel's SVG element that the page's script reads: scales of both axes (not of
    a sketch, which the script leaves as it is), their titles, the ticks of x, and which axis is the
    time ("x", "y" or "").

    `frame` is the panel's area with its scales, whose `words` are their ends as text. Of an axis,
    `words` is the title, `n_ticks` about how many ticks it has (5 by default), `ticks` those that
    are given, each with its text.
    """
    attributes: dict[str, object] = {}
    if not _is_sketch(panel):
        attributes |= {"data_x": frame.x.words, "data_y": frame.y.words}
    attributes |= {
        "data_x_words": panel.x.words,
        "data_y_words": panel.y.words,
        "data_time": panel.time,
        "data_x_ticks": " ".join(f"{number:g}={text}" for number, text in panel.x.ticks),
    }
    if (panel.x.n_ticks, panel.y.n_ticks) != (5, 5):
        attributes["data_counts"] = f"{panel.x.n_ticks} {panel.y.n_ticks}"
    return attributes


def write_tables(drawings: Sequence[Plate], folder: Path) -> dict[str, str]:
    """Write the numbers of each figure as CSV to `figures/NAME.csv` of a folder; returns the texts
    by the figures' names.
    """
    figure_folder = folder / "figures"
    figure_folder.mkdir()
    tables = {drawing.name: drawing.csv() for drawing in drawings}
    for name, text in tables.items():
        (figure_folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return tables
