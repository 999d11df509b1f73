"""An error budget in sentences, cells and JSON."""

from __future__ import annotations

from typing import Any

from reports.charts.templating import in_template
from reports.comparison.budget import Budget, ErrorBudget, Term
from reports.comparison.judged import JudgedPair
from reports.comparison.metrics import Metric
from reports.comparison.words import amount, value_of

# Share of a discrepancy and its uncertainty below which a term says nothing.
_NEGLIGIBLE = 1e-3


def negligible_terms(budget: ErrorBudget) -> tuple[str, ...]:
    """Names of the terms that are below a thousandth of every discrepancy of the first table, with
    its uncertainty.
    """
    headlines = [entry for entry in budget.budgets if entry.metric.headline]
    names = []
    for place, term in enumerate(headlines[0].terms if headlines else ()):
        if all(_is_negligible(entry, entry.terms[place]) for entry in headlines):
            names.append(term.name)
    return tuple(names)


def _is_negligible(entry: Budget, term: Term) -> bool:
    """Whether a term is known, and too small to matter in a metric."""
    if term.uncertainty is None or entry.total is None:
        return False
    size = abs(term.value or 0.0) + term.uncertainty
    return size <= _NEGLIGIBLE * (abs(entry.total) + (entry.uncertainty or 0.0))


def budget_table(
    budget: ErrorBudget, without: tuple[str, ...] = ()
) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[tuple[str, ...]]]:
    """The table of the error budget as text: column heads, rows of the metrics that the page's
    first table shows, and rows of the other metrics.

    There is a column for each source of error, but for those named in `without` and those that
    contribute nothing anywhere. The last column says, for half-planes, whether the uncertainty
    covers what the sources leave unexplained; for real bodies, whether the idealisation error is
    larger than its uncertainty.
    """
    term_names = [term.name for term in budget.budgets[0].terms] if budget.budgets else []
    are_half_planes = all(entry.half_planes for entry in budget.budgets)
    name_of_rest = "unexplained" if are_half_planes else "idealisation"
    heads = (
        "metric",
        "E",
        *term_names,
        name_of_rest,
        "± u",
        "covered" if are_half_planes else "resolved",
    )
    rows = [_budget_row(entry) for entry in budget.budgets]
    shown_columns = []
    for column, head in enumerate(heads):
        is_none_everywhere = all(row[column] == "none" for row in rows)
        if head not in without and not is_none_everywhere:
            shown_columns.append(column)
    first_rows = []
    other_rows = []
    for entry, row in zip(budget.budgets, rows, strict=True):
        cells = tuple(row[column] for column in shown_columns)
        if entry.metric.headline:
            first_rows.append(cells)
        else:
            other_rows.append(cells)
    return tuple(heads[column] for column in shown_columns), first_rows, other_rows


def _budget_row(budget: Budget) -> tuple[str, ...]:
    """Cells of a metric: error, terms, what they leave, its uncertainty, verdict."""
    metric = budget.metric
    uncertainty = "not measured"
    if budget.uncertainty is not None:
        uncertainty = amount(budget.uncertainty, metric)
    terms = [share(term, metric) for term in budget.terms]
    rest = amount(budget.rest, metric, plus=True)
    label = metric.short or metric.label
    return (label, value_of(metric), *terms, rest, uncertainty, _judgement_in_short(budget))


def share(term: Term, metric: Metric) -> str:
    """A term in a cell: its value and uncertainty, "none", or "not measured"."""
    if term.uncertainty is None:
        return "not measured"
    if term.value is None:
        return f"± {amount(term.uncertainty, metric)}" if term.uncertainty else "none"
    value = amount(term.value, metric, plus=True)
    uncertainty = amount(term.uncertainty, metric)
    is_exact = not any(digit in uncertainty for digit in "123456789")
    return value if is_exact else f"{value} ± {uncertainty}"


def _judgement(budget: Budget) -> str:
    """In words: of half-planes, whether the uncertainty covers what is left over; of real bodies,
    whether an idealisation error stands out of it.
    """
    if budget.resolved is None:
        return "not known: a term was not measured"
    if budget.half_planes:
        return "not covered" if budget.resolved else "covered"
    return "resolved" if budget.resolved else "not resolved"


def _judgement_in_short(budget: Budget) -> str:
    """In a word, whether the uncertainty covers what is left (half-planes) or an idealisation error
    stands out of it (real bodies): "yes", "no" or "unknown".
    """
    if budget.resolved is None:
        return "unknown"
    return "yes" if budget.resolved is not budget.half_planes else "no"


def cost(budget: ErrorBudget) -> str:
    """A sentence on the runs of an error budget and the time that they took."""
    refinements = budget.refinements
    pairs = [run for pair in refinements.penalty for run in pair]
    runs = {run.label: run for run in (*refinements.mesh, *refinements.far_field, *pairs)}
    return in_template("budget_cost", budget.cost, list(runs.values()), refinements.not_measured)


def honest(budget: ErrorBudget | None, metric: Metric) -> bool | None:
    """Whether the stated uncertainty of a metric covers its known error; None where that was not
    assessed.
    """
    entries = () if budget is None else budget.budgets
    return next((entry.honest for entry in entries if entry.metric.key == metric.key), None)


def honesty(comparison: JudgedPair, budget: ErrorBudget | None) -> bool | None:
    """Whether every stated uncertainty of the first table covers the known error; None where none
    was assessed.
    """
    answers = {honest(budget, metric) for metric in comparison.headlines}
    return None if answers == {None} else False not in answers


def budget_content(budget: ErrorBudget) -> dict[str, Any]:
    """An error budget for comparison.json: cost, coverage, and the terms of every metric."""
    return {
        "cost": budget.cost,
        "words": cost(budget),
        "honest": budget.honest,
        "metrics": {entry.metric.key: _entry_content(entry) for entry in budget.budgets},
    }


def _entry_content(budget: Budget) -> dict[str, Any]:
    """The budget of one metric for comparison.json."""
    return {
        "E": budget.total,
        "terms": {term.name: {**vars(term), "measured": term.measured} for term in budget.terms},
        "unexplained" if budget.half_planes else "idealisation": budget.rest,
        "u": budget.uncertainty,
        "resolved": budget.resolved,
        "honest": budget.honest,
        "verdict": _judgement(budget),
    }
