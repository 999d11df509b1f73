"""Sketches of a few characters: dots of braille where the terminal can show them, full stops, quotes and colons where not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reports.sketches import Silhouette, loop, silhouettes
from scenes import Scene

Array = NDArray[np.float64]

BODIES, LOOP, ROWS = 14, 11, 4
# Bits of the dots of a braille character, by row and column.
_BRAILLE = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
_ASCII = np.array([[1], [2]])


@dataclass(frozen=True)
class Font:
    """How many dots a character holds, and which character stands for a set of them. Dots are square in both fonts."""

    bits: NDArray[np.int64]
    character: Callable[[int], str]

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns of dots in a character."""
        return self.bits.shape[0], self.bits.shape[1]


BRAILLE = Font(_BRAILLE, lambda bits: chr(0x2800 + bits) if bits else " ")
PLAIN = Font(_ASCII, lambda bits: " '.:"[bits])


def font_for(encoding: str | None) -> Font:
    """The font that a stream of this encoding can carry.

    >>> font_for("ascii") is PLAIN, font_for("utf-8") is BRAILLE
    (True, True)
    """
    try:
        chr(0x28FF).encode(encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return PLAIN
    return BRAILLE


def thumbnail(scene: Scene, font: Font) -> list[str]:
    """ROWS lines of one width: the bodies to scale (a flat gap exaggerated), then Q upwards over P, from 0 to its largest."""
    return [f"{left} {right}" for left, right in zip(_bodies(scene, font), _loads(scene, font), strict=True)]


def _bodies(scene: Scene, font: Font) -> list[str]:
    dots = _canvas(BODIES, font)
    both = silhouettes(scene)
    points = np.vstack([body.outline for body in both])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = min((dots.shape[1] - 1) / (high[0] - low[0]), (dots.shape[0] - 1) / (high[1] - low[1]))
    room = (np.array(dots.shape[::-1]) - 1 - scale * (high - low)) / 2
    for body in both:
        for line in _lines(body):
            _draw(dots, scale * (line - low) + room)
    return _text(dots, font)


def _lines(body: Silhouette) -> list[Array]:
    return [body.face] if body.half_plane else [body.outline]


def _loads(scene: Scene, font: Font) -> list[str]:
    dots = _canvas(LOOP, font)
    path = loop(scene)
    points = np.vstack([path.points, [[0.0, 0.0]]])
    low, high = points.min(axis=0), points.max(axis=0)
    spread = high - low
    flat = spread <= 1e-12 * max(float(np.abs(points).max()), 1e-300)
    scale = (np.array(dots.shape[::-1]) - 1) / np.where(flat, 1.0, spread)
    middle = np.where(flat, (np.array(dots.shape[::-1]) - 1) / 2, 0.0)
    _draw(dots, (path.initial_loading - low) * scale + middle, every=3)
    _draw(dots, (path.cycle - low) * scale + middle)
    return _text(dots, font)


def _canvas(columns: int, font: Font) -> NDArray[np.bool_]:
    rows, across = font.size
    return np.zeros((ROWS * rows, columns * across), dtype=bool)


def _draw(dots: NDArray[np.bool_], points: Array, every: int = 1) -> None:
    """Set the dots along a chain of straight lines, (n, 2) in dots, y upwards; with `every` > 1 a dotted one."""
    count = 0
    for first, last in pairwise(points):
        steps = max(int(np.ceil(np.abs(last - first).max())), 1)
        for point in first + np.linspace(0, 1, steps + 1)[:, None] * (last - first):
            if count % every == 0:
                _set(dots, point)
            count += 1
    if len(points) == 1:
        _set(dots, points[0])


def _set(dots: NDArray[np.bool_], point: Array) -> None:
    # Half up: numpy's rint would send 7.5 and 8.5 to one dot, and leave a gap beside it.
    x, y = np.floor(point + 0.5 - 1e-9).astype(int)
    dots[dots.shape[0] - 1 - y, x] = True


def _text(dots: NDArray[np.bool_], font: Font) -> list[str]:
    rows, across = font.size
    cells = dots.reshape(ROWS, rows, -1, across).transpose(0, 2, 1, 3)
    bits = np.tensordot(cells, font.bits, axes=((2, 3), (0, 1)))
    return ["".join(font.character(int(cell)) for cell in line) for line in bits]
