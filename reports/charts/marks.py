"""Marks of a drawing as SVG text. Every function takes the frame that it draws in; words are escaped here and nowhere else."""

from __future__ import annotations

import base64
import math
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.charts.scale import Scale


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


def attributes(given: Mapping[str, object]) -> str:
    """Attributes as text, "_" in a name read as "-", empty ones left out.

    >>> attributes({"data_label": 'a "b"', "x": 1.5, "class_": ""})
    ' data-label="a &quot;b&quot;" x="1.5"'
    """
    parts = ((name.rstrip("_").replace("_", "-"), f"{v:.2f}".rstrip("0").rstrip(".") if isinstance(v, float) else str(v))
             for name, v in given.items() if v is not None and v != "")  # fmt: skip
    return "".join(f' {name}="{escape(value)}"' for name, value in parts)


def element(name: str, content: str = "", /, **given: object) -> str:
    """An element; `content` is SVG already. A place that is no number draws nothing."""
    if any(isinstance(value, float) and not math.isfinite(value) for value in given.values()):
        return ""
    return f"<{name}{attributes(given)}>{content}</{name}>" if content else f"<{name}{attributes(given)}/>"


def words(x: float, y: float, text: str, /, **given: object) -> str:
    """A text at a place of the drawing."""
    return element("text", escape(text), x=float(x), y=float(y), **given)


def path_of(horizontal: ArrayLike, vertical: ArrayLike) -> str:
    """A line through places; a NaN breaks it. Places that repeat the last one to a hundredth are left out.

    >>> path_of([0, 1, np.nan, 2, 3], [0, 1, 1, 1, 1])
    'M0 0L1 1M2 1L3 1'

    A place that stands alone is a line to itself, which round ends make a dot.

    >>> path_of([0, np.nan, 2], [0, 1, 1])
    'M0 0L0 0M2 1L2 1'
    """
    across, down = np.round(np.asarray(horizontal, dtype=float), 2), np.round(np.asarray(vertical, dtype=float), 2)
    good = np.isfinite(across) & np.isfinite(down)
    moved = np.ones(len(across), dtype=bool)
    moved[1:] = (across[1:] != across[:-1]) | (down[1:] != down[:-1]) | ~good[:-1]
    starts = good & ~np.concatenate([[False], good[:-1]])
    alone = starts & ~np.concatenate([good[1:], [False]])
    rows = np.flatnonzero(good & moved)
    places = {k: f"{across[k]:g} {down[k]:g}" for k in rows.tolist()}
    return "".join(f"M{at}L{at}" if alone[k] else f"{'M' if starts[k] else 'L'}{at}" for k, at in places.items())


def curve(frame: Frame, x: ArrayLike, y: ArrayLike, css: str, label: str = "", **given: object) -> str:
    """A line through points; `label` is what a pointer shows for it."""
    return element(
        "path", d=path_of(frame.x.place(x), frame.y.place(y)) or "M0 0", class_=f"curve {css}", data_label=label, **given
    )


def dot(frame: Frame, x: float, y: float, css: str, radius: float = 4.0, **given: object) -> str:
    """A round mark."""
    return element("circle", cx=float(frame.x.place(x)), cy=float(frame.y.place(y)), r=radius, class_=css, **given)


def vertical(frame: Frame, x: float, css: str, **given: object) -> str:
    """A line from top to bottom at x."""
    _, top, _, bottom = frame.box
    place = float(frame.x.place(x))
    return element("line", x1=place, x2=place, y1=top, y2=bottom, class_=css, **given)


def horizontal(frame: Frame, y: float, css: str, **given: object) -> str:
    """A line from left to right at y."""
    left, _, right, _ = frame.box
    place = float(frame.y.place(y))
    return element("line", x1=left, x2=right, y1=place, y2=place, class_=css, **given)


def block(frame: Frame, x: tuple[float, float], y: tuple[float, float], css: str, **given: object) -> str:
    """A filled rectangle between two x and two y."""
    (left, right), (low, high) = np.sort(frame.x.place(x)), np.sort(frame.y.place(y))
    return element("rect", x=float(left), y=float(low), width=float(right - left), height=float(high - low), class_=css, **given)


def image(frame: Frame, pixels: NDArray[np.uint8], colours: Sequence[str]) -> str:
    """A map over the whole frame, its first row on top; `colours` as #rrggbb, one for each number in `pixels`."""
    left, top, right, bottom = frame.box
    address = "data:image/png;base64," + base64.b64encode(png(pixels, colours)).decode()
    return element(
        "image", x=left, y=top, width=right - left, height=bottom - top, href=address, preserveAspectRatio="none", class_="map"
    )


def png(pixels: NDArray[np.uint8], colours: Sequence[str]) -> bytes:
    """A picture of indexed colours as a PNG file (ISO/IEC 15948: 8 bits, colour type 3, no filter).

    >>> png(np.zeros((1, 1), np.uint8), ["#ffffff"])[:8]
    b'\\x89PNG\\r\\n\\x1a\\n'
    """
    height, width = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.astype(np.uint8)], axis=1)
    palette = b"".join(bytes.fromhex(colour.removeprefix("#")) for colour in colours)
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"PLTE", palette), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks
    )
