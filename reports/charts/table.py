"""Tables as text: CSV that a spreadsheet opens and computes nothing of, and Markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

# Column heading (with unit) -> values, all of one length.
Table: TypeAlias = Mapping[str, Sequence[Any] | NDArray[Any]]
_FORMULA = ("=", "+", "-", "@", "\t")


def harmless(cell: str) -> str:
    """The text of a CSV cell; with an apostrophe before it where a spreadsheet would compute it. Numbers stay as they are.

    >>> harmless("=HYPERLINK(A1)"), harmless("-1e-3"), harmless("pad"), harmless(" @SUM(A1)")
    ("'=HYPERLINK(A1)", '-1e-3', 'pad', "' @SUM(A1)")
    """
    cell = cell.replace("\r", " ")  # no writer of CSV quotes it, and some readers end the row there
    if not (cell.startswith(_FORMULA) or cell.lstrip().startswith(_FORMULA)):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def table_text(table: Table) -> str:
    """Columns of equal length as CSV text, numbers to the last digit; an empty cell stands for "no such thing".

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


def markdown_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown.

    >>> print(markdown_table(("x", "|q|"), [("0", "1")]))
    | x | \\|q\\| |
    | --- | --- |
    | 0 | 1 |
    """
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
