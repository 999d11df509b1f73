"""A panel: frame, axes, marks and words as one SVG document that the page styles and the page's script can move."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from reports.charts.marks import Frame, element, words
from reports.charts.scale import Scale, labels, ticks

# Room around a frame for the words beside its axes [units of the drawing, in which letters are 12 high].
LEFT, RIGHT, TOP, BOTTOM = 72.0, 20.0, 12.0, 46.0


@dataclass(frozen=True)
class Axis:
    """What an axis shows: from `low` to `high`, its words, whether it is logarithmic, about how many ticks."""

    low: float
    high: float
    words: str
    log: bool = False
    count: int = 5  # 0: none


def frame(x: Axis, y: Axis, width: float = 440.0, height: float = 300.0, *, top: float = TOP, bottom: float = BOTTOM) -> Frame:
    """The frame of two axes in a drawing of that size."""
    return Frame(Scale(x.low, x.high, LEFT, width - RIGHT, x.log), Scale(y.low, y.high, height - bottom, top, y.log), width, height)


def equal(x: Axis, y: Axis, width: float = 440.0, height: float = 300.0, *, top: float = TOP) -> Frame:
    """A frame in which both axes have one scale; the one that has room to spare shows more on both sides."""
    plain = frame(x, y, width, height, top=top)
    across, up = plain.x.end - plain.x.start, plain.y.start - plain.y.end
    unit = max((x.high - x.low) / across, (y.high - y.low) / up)
    middle_x, middle_y = (x.high + x.low) / 2, (y.high + y.low) / 2
    wide, tall = unit * across / 2, unit * up / 2
    across_axis, up_axis = Axis(middle_x - wide, middle_x + wide, x.words), Axis(middle_y - tall, middle_y + tall, y.words)
    return frame(across_axis, up_axis, width, height, top=top)


def panel(
    frame: Frame, x: Axis, y: Axis, marks: Iterable[str], alt: str, *, clip: str, time: str = "", extra: str = "", css: str = ""
) -> str:
    """The SVG document.

    Parameters
    ----------
    marks : SVG inside the frame, clipped to it
    alt : what it shows, for who can't see it
    clip : name of the panel, used once on a page
    time : "x" or "y" where that axis is the time, so that the instant shown is marked on it
    extra : SVG over the frame that is not clipped
    """
    left, top, right, bottom = frame.box
    area = {"x": left, "y": top, "width": right - left, "height": bottom - top}
    content = "".join(
        (
            element("clipPath", element("rect", **area), id=f"clip-{clip}"),
            element("rect", class_="area", **area),
            _grid(frame, x, y),
            element("g", "".join(marks) or " ", clip_path=f"url(#clip-{clip})", class_="marks"),
            _frame_lines(frame),
            extra,
        )
    )
    return element(
        "svg",
        content,
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {frame.width:g} {frame.height:g}",
        role="img",
        aria_label=alt,
        class_=f"panel {css}".strip(),
        id=f"panel-{clip}",
        data_x=frame.x.words,
        data_y=frame.y.words,
        data_x_words=x.words,
        data_y_words=y.words,
        data_time=time,
    )


def _grid(frame: Frame, x: Axis, y: Axis) -> str:
    """Grid lines, numbers beside the axes, and what the axes show."""
    left, top, right, bottom = frame.box
    parts = []
    numbers = ticks(x.low, x.high, x.count, log=x.log)
    for place, text in zip(frame.x.place(numbers), labels(numbers), strict=True):
        parts.append(element("line", x1=float(place), x2=float(place), y1=top, y2=bottom, class_="grid"))
        if frame.height - bottom > 16:
            parts.append(words(place, bottom + 15, text, class_="tick", text_anchor="middle"))
    numbers = ticks(y.low, y.high, y.count, log=y.log) if y.count else []
    for place, text in zip(frame.y.place(numbers), labels(numbers), strict=True):
        parts.append(element("line", x1=left, x2=right, y1=float(place), y2=float(place), class_="grid upright"))
        parts.append(words(left - 6, place + 4, text, class_="tick upright", text_anchor="end"))
    middle = (top + bottom) / 2
    if x.words and frame.height - bottom > 30:
        parts.append(words((left + right) / 2, bottom + 36, x.words, class_="name", text_anchor="middle"))
    if y.words:
        turned = f"rotate(-90 12 {middle:g})"
        parts.append(words(12, middle, y.words, class_="name", text_anchor="middle", transform=turned))
    return "".join(parts)


def _frame_lines(frame: Frame) -> str:
    left, top, right, bottom = frame.box
    return element("path", d=f"M{left:g} {top:g}L{left:g} {bottom:g}L{right:g} {bottom:g}", class_="axis")
