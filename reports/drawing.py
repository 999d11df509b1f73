"""What every figure shares: palette, style, and the two forms that it leaves in, SVG and CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.cells import harmless
from scenes import SurfaceState

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Column heading (with unit) -> values, all of one length.
Table = Mapping[str, Sequence[Any] | NDArray[Any]]

# Okabe and Ito's colours, told apart by all common forms of colour vision and, in these pairs, in grey.
# The reference is a broad pale band, the result a thin dark line on it: where they agree both are seen.
REFERENCE, RESULT, DIFFERENCE, QUIET = "#56B4E9", "#B33A00", "#5B2A86", "#6b6b6b"
BANDS: tuple[dict[str, Any], ...] = tuple(
    {"color": colour, "lw": 3.6, "solid_capstyle": "butt"} for colour in (REFERENCE, "#F0C75E")
)
THIN: tuple[dict[str, Any], ...] = tuple({"color": RESULT, "lw": 0.9, "ls": line} for line in ("-", "--"))
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#333333", "#56B4E9")
STATE_COLOURS = {
    SurfaceState.OPEN: "#f7f7f7",
    SurfaceState.STICK: "#c4c4c4",
    SurfaceState.SLIP_FORWARD: "#E69F00",
    SurfaceState.SLIP_REVERSE: "#0072B2",
}
STATE_NAMES = {
    SurfaceState.OPEN: "open",
    SurfaceState.STICK: "stick",
    SurfaceState.SLIP_FORWARD: "forward slip",
    SurfaceState.SLIP_REVERSE: "reverse slip",
}
BODY_COLOURS = {"lower": "#cfe3f2", "upper": "#f5dfb8"}
SUPPORT_WORDS = {
    "fixed": "fixed",
    "rollers": "on rollers along x",
    "guided": "guided along y",
    "half_plane": "joined to the half-plane around it",
}
STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "svg.hashsalt": "halfplane",  # the same data gives the same file
}


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure with its words and its numbers.

    Attributes
    ----------
    name : stem of its files; title, caption : for the page; alt : what it shows, for who can't see it
    table : column heading (with unit) -> values, all of one length; what the figure draws
    """

    name: str
    title: str
    caption: str
    alt: str
    figure: Figure
    table: Table

    def svg(self) -> str:
        """The figure as an SVG document."""
        import matplotlib as mpl

        text = io.StringIO()
        with mpl.rc_context(STYLE):
            self.figure.savefig(text, format="svg", metadata={"Date": None}, dpi=160)
        return text.getvalue()

    def csv(self) -> str:
        """The table, numbers to the last digit; an empty cell stands for "no such thing"."""
        return table_text(self.table)


def literal(figure: Figure) -> Figure:
    """The figure with every dollar sign a dollar sign: words of others are no formulas, and a half one would end the drawing."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        words = text.get_text()
        if "$" in words and "mathdefault" not in words:  # the powers of ten beside a logarithmic axis are formulas
            text.set_text(words.replace("$", r"\$"))
    return figure


def table_text(table: Table) -> str:
    """Columns of equal length as CSV text.

    >>> table_text({"x": [0.5, float("nan")], "state": ["stick", "open"]})
    'x,state\\n0.5,stick\\n,open\\n'
    """
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(map(harmless, table))
    rows.writerows(zip(*map(_cells, table.values()), strict=True))
    return text.getvalue()


def _cells(column: Sequence[Any] | NDArray[Any]) -> list[Any]:
    """A column as text; a number that stands in it often is written once and used again."""
    if isinstance(column, np.ndarray) and column.dtype.kind in "fiu":
        values, places = np.unique(column, return_inverse=True, equal_nan=True)
        texts = ["" if value != value else repr(value) for value in values.tolist()]  # noqa: PLR0124 -- NaN alone differs from itself
        return [texts[place] for place in places.ravel().tolist()]
    return [_cell(value) for value in column]


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return harmless(value)
    number = value.item() if hasattr(value, "item") else value
    return "" if number != number else repr(number)  # noqa: PLR0124


@contextmanager
def canvas(width: float, height: float) -> Generator[Figure, None, None]:
    """A figure of `width` by `height` inches in the common style."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        yield Figure(figsize=(width, height))


def label_axes(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Axis labels and a title."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title)


def legend_above(axes: Axes, columns: int) -> None:
    """A legend in a row above the axes, where it can't hide a curve."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.3, handlelength=1.8)
