"""Words of others in tables that a spreadsheet opens: text that it would take for a formula is marked as text."""

from __future__ import annotations

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
