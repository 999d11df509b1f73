"""What the figures of the paper share: lines by label and look, letters at points, the legend of what a figure holds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from reports.charts.marks import Axis, Band, Curve, Dot, Mark, Note
from reports.charts.plate import Key, Panel, Plate
from reports.charts.table import Table

# Looks of curves that a figure tells apart, the first to the last.
FAMILY = ("c0 solid", "c1 dash", "c2 dashdot", "c3 dot")


def line(x: ArrayLike, y: ArrayLike, label: str = "", look: str = "solid") -> Curve:
    """A curve; NaN leaves a gap. Without a label it is not in the legend, but goes with a labelled one of its look."""
    return Curve(np.asarray(x, dtype=float), np.asarray(y, dtype=float), look, label)


def named(
    x: float, y: float, text: str, shift: tuple[float, float] = (0.0, 0.0), look: str = "", *, dot: bool = False, css: str = "word"
) -> Iterator[Mark]:
    """A text about `shift` units right and up of a point, of colour `look`; a dot is drawn there if wanted."""
    if dot:
        yield Dot(x, y, f"p{look}" if look else "event", 2.8)
    if text:
        yield Note(x, y, text, f"{css} t{look}" if look else css, "middle", (1.3 * shift[0], 4.0 - 1.3 * shift[1]))


def plate(
    name: str, title: str, caption: str, alt: str, panels: Sequence[Panel], table: Table, columns: int = 1, keys: Iterable[Key] = ()
) -> Plate:
    """A figure with the legend of its labelled curves and bands, each once."""
    shown = [mark for panel in panels for mark in panel.marks if isinstance(mark, Curve | Band) and mark.label]
    legend = {mark.label: Key(mark.css, mark.label, isinstance(mark, Band)) for mark in shown} | {key.text: key for key in keys}
    return Plate(name, title, caption, alt, tuple(panels), table, tuple(legend.values()), columns)


def axes(x: tuple[float, float, str], y: tuple[float, float, str], ticks: tuple[tuple[float, str], ...] = ()) -> tuple[Axis, Axis]:
    """Two axes as (low, high, words), with ticks of one's own along x."""
    return Axis(*x, ticks=ticks), Axis(*y)
