"""An error budget in sentences, cells and JSON."""

from __future__ import annotations

from typing import Any

from reports.charts.templating import in_template
from reports.comparison.budget import Budget, ErrorBudget, Term
from reports.comparison.metrics import Metric
from reports.comparison.words import term_in_words, value_in_words

# A term below this share of the discrepancy with its uncertainty is negligible.
_NEGLIGIBLE_SHARE = 1e-3


def negligible_terms(budget: ErrorBudget) -> tuple[str, ...]:
    """Names of the sources of error that are negligible in every metric of the page's first table:
    below a thousandth of the discrepancy with its uncertainty.
    """
    first_budgets = [
        budget_of_metric for budget_of_metric in budget.budgets if budget_of_metric.metric.headline
    ]
    names = []
    # all budgets have the same sources of error, in the same order
    for index, term in enumerate(first_budgets[0].terms if first_budgets else ()):
        if all(
            _is_negligible(budget_of_metric, budget_of_metric.terms[index])
            for budget_of_metric in first_budgets
        ):
            names.append(term.name)
    return tuple(names)


def _is_negligible(budget_of_metric: Budget, term: Term) -> bool:
    """Whether `term` was measured, and is too small to matter in the budget of a metric."""
    if term.uncertainty is None:
        return False
    size_of_term = abs(term.value or 0.0) + term.uncertainty
    size_of_error = abs(budget_of_metric.error) + (budget_of_metric.uncertainty or 0.0)
    return size_of_term <= _NEGLIGIBLE_SHARE * size_of_error


def budget_table(
    budget: ErrorBudget, sources_left_out: tuple[str, ...] = ()
) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[tuple[str, ...]]]:
    """The table of the error budget as text: column heads, rows of the metrics that the page's
    first table shows, and rows of the other metrics.

    A row holds the metric, its error E, one cell for each source of error, the part that these
    leave, its uncertainty u, and a verdict. Sources named in `sources_left_out`, and columns with
    "none" in every row, are not shown. The verdict says, for half-planes, whether u covers the
    unexplained part; for real bodies, whether the idealisation error is larger than u.

    An entry of `budget.budgets` is the budget of one metric; `headline` states whether the page's
    first table shows the metric.
    """
    # sources of error, the same for all metrics: mesh, penalty layer, ...
    term_names = [term.name for term in budget.budgets[0].terms] if budget.budgets else []
    are_half_planes = all(budget_of_metric.are_half_planes for budget_of_metric in budget.budgets)
    name_of_rest = "unexplained" if are_half_planes else "idealisation"
    heads = (
        "metric",
        "E",
        *term_names,
        name_of_rest,
        "± u",
        "covered" if are_half_planes else "resolved",
    )
    rows = [_budget_row(budget_of_metric) for budget_of_metric in budget.budgets]
    shown_columns = []
    for column_number, head in enumerate(heads):
        is_none_everywhere = all(row[column_number] == "none" for row in rows)
        if head not in sources_left_out and not is_none_everywhere:
            shown_columns.append(column_number)
    first_rows = []
    other_rows = []
    for budget_of_metric, row in zip(budget.budgets, rows, strict=True):
        cells = tuple(row[column_number] for column_number in shown_columns)
        if budget_of_metric.metric.headline:
            first_rows.append(cells)
        else:
            other_rows.append(cells)
    return tuple(heads[column_number] for column_number in shown_columns), first_rows, other_rows


def _budget_row(budget_of_metric: Budget) -> tuple[str, ...]:
    """Cells of one metric: name, error, terms, the rest that they leave, uncertainty, verdict. A
    term is the error by one source; the rest is the error minus all terms.
    """
    metric = budget_of_metric.metric
    uncertainty_in_words = "not measured"
    if budget_of_metric.uncertainty is not None:
        uncertainty_in_words = term_in_words(budget_of_metric.uncertainty, metric)
    cells_of_terms = [cell_of_term(term, metric) for term in budget_of_metric.terms]
    rest_in_words = term_in_words(budget_of_metric.rest_of_error, metric, plus=True)
    label = metric.short or metric.label
    return (
        label,
        value_in_words(metric),
        *cells_of_terms,
        rest_in_words,
        uncertainty_in_words,
        _verdict_in_short(budget_of_metric),
    )


def cell_of_term(term: Term, metric: Metric) -> str:
    """A term as the text of a cell: its value and uncertainty, "none", or "not measured"."""
    if term.uncertainty is None:
        return "not measured"
    if term.value is None:
        return f"± {term_in_words(term.uncertainty, metric)}" if term.uncertainty else "none"
    value = term_in_words(term.value, metric, plus=True)
    uncertainty = term_in_words(term.uncertainty, metric)
    is_exact = not any(digit in uncertainty for digit in "123456789")
    return value if is_exact else f"{value} ± {uncertainty}"


def _verdict_in_words(budget_of_metric: Budget) -> str:
    """The verdict in words: for half-planes, whether the uncertainty covers the rest; for real
    bodies, whether the idealisation error is larger than its uncertainty.
    """
    if budget_of_metric.is_resolved is None:
        return "not known: a term was not measured"
    if budget_of_metric.are_half_planes:
        return "not covered" if budget_of_metric.is_resolved else "covered"
    return "resolved" if budget_of_metric.is_resolved else "not resolved"


def _verdict_in_short(budget_of_metric: Budget) -> str:
    """The verdict in a word, "yes", "no" or "unknown": for half-planes, whether the uncertainty
    covers the rest; for real bodies, whether the idealisation error is larger than its uncertainty.
    """
    if budget_of_metric.is_resolved is None:
        return "unknown"
    is_good = (
        not budget_of_metric.is_resolved
        if budget_of_metric.are_half_planes
        else budget_of_metric.is_resolved
    )
    return "yes" if is_good else "no"


def cost_in_words(budget: ErrorBudget) -> str:
    """A sentence on the runs of an error budget and the time that they took."""
    refinements = budget.refinements
    pairs = [run for pair in refinements.penalty_pairs for run in pair]
    runs = {run.label: run for run in (*refinements.mesh_runs, *refinements.far_field_runs, *pairs)}
    return in_template(
        "budget_cost", budget.cpu_time_ratio, list(runs.values()), refinements.reasons_not_measured
    )


def budget_content(budget: ErrorBudget) -> dict[str, Any]:
    """An error budget for comparison.json: cost, coverage, and the terms of every metric."""
    return {
        "cost": budget.cpu_time_ratio,
        "words": cost_in_words(budget),
        "honest": budget.coverage_in_words,
        "metrics": {
            budget_of_metric.metric.key: _content_of_metric(budget_of_metric)
            for budget_of_metric in budget.budgets
        },
    }


def _content_of_metric(budget_of_metric: Budget) -> dict[str, Any]:
    """The budget of one metric for comparison.json: its error E, the part of each source, what they
    leave, uncertainty u, and whether u covers the rest ("honest").
    """
    return {
        "E": budget_of_metric.error,
        "terms": {term.name: _term_content(term) for term in budget_of_metric.terms},
        "unexplained"
        if budget_of_metric.are_half_planes
        else "idealisation": budget_of_metric.rest_of_error,
        "u": budget_of_metric.uncertainty,
        "resolved": budget_of_metric.is_resolved,
        "honest": budget_of_metric.is_covered,
        "verdict": _verdict_in_words(budget_of_metric),
    }


def _term_content(term: Term) -> dict[str, Any]:
    """One source of error in one metric for comparison.json: the error by it with its uncertainty,
    how that was measured, whether the uncertainty is a bound (never exceeded), and the order and
    kind of convergence of the runs that measured it.
    """
    return {
        "name": term.name,
        "value": term.value,
        "uncertainty": term.uncertainty,
        "how": term.how_measured,
        "bound": term.is_bound,
        "order": term.order,
        "kind": term.kind,
        "measured": term.is_measured,
    }
