"""What a notebook shows of a comparison: the verdict and its table."""

from __future__ import annotations

from html import escape

from reports.budget_words import honest_of
from reports.comparison import Comparison
from reports.wording import accuracy_of, how_judged, lead, open_value_of, tolerance_of, unit_of, verdict

_HEADS = ("metric", "value ± u", "as a share", "tolerance", "accurate", "honest")


def comparison_html(comparison: Comparison) -> str:
    """Title, verdict in a sentence, and a line for each headline metric; every word escaped."""
    rows = (
        (
            metric.label,
            open_value_of(metric),
            unit_of(metric),
            tolerance_of(metric),
            accuracy_of(metric),
            honest_of(comparison, metric),
        )
        for metric in comparison.headlines
    )
    heads = "".join(f"<th>{head}</th>" for head in _HEADS)
    cells = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    scene = comparison.scene
    return (
        f"<div><b>{escape(scene.title or scene.name)}</b><p><b>{escape(lead(comparison))}</b> {escape(verdict(comparison))}</p>"
        f"<table><tr>{heads}</tr>{cells}</table><p>{escape(how_judged(comparison))}</p></div>"
    )
