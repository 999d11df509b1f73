"""The error budget in words and rows: the same in the terminal, on the page and in comparison.json."""

from __future__ import annotations

from typing import Any

from reports.budget import Budget, ErrorBudget, Term
from reports.comparison import Comparison
from reports.verdicts import Metric
from reports.wording import accuracy_of, value_of

# Terms that are nothing but bounds of rounding in nearly every run: on the page and in the file, not in the terminal.
_SMALL = ("solver", "half-plane theory")


def heads(budget: ErrorBudget, *, full: bool = True) -> tuple[str, ...]:
    """Column heads of the table."""
    names = [term.name for term in budget.budgets[0].terms if full or term.name not in _SMALL] if budget.budgets else []
    rest = "unexplained" if all(one.half_planes for one in budget.budgets) else "idealisation"
    return ("metric", "E", *names, rest, "± u", "verdict", "accurate")


def narrow(heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Both for a terminal: without the verdict on accuracy, which the table above has, and without what is none everywhere."""
    kept = [k for k, head in enumerate(heads) if head != "accurate" and any(row[k] != "none" for row in rows)]
    return tuple(heads[k] for k in kept), [tuple(row[k] for k in kept) for row in rows]


def rows(budget: ErrorBudget, *, full: bool = True, headline: bool = True) -> list[tuple[str, ...]]:
    """One row for each metric, as `heads` has the columns."""
    return [
        (
            one.metric.label,
            value_of(one.metric),
            *(share(term, one.metric) for term in one.terms if full or term.name not in _SMALL),
            _amount(one.rest, one.metric, signed=True),
            "not measured" if one.uncertainty is None else _amount(one.uncertainty, one.metric),
            judgement(one),
            accuracy_of(one.judged),
        )
        for one in budget.budgets
        if one.metric.definition.headline is headline
    ]


def share(term: Term, metric: Metric) -> str:
    """A term in a cell: its value and uncertainty, "none", or "not measured"."""
    if term.uncertainty is None:
        return "not measured"
    if term.value is None:
        return f"± {_amount(term.uncertainty, metric)}" if term.uncertainty else "none"
    return f"{_amount(term.value, metric, signed=True)} ± {_amount(term.uncertainty, metric)}"


def _amount(value: float, metric: Metric, *, signed: bool = False) -> str:
    """Two digits, in per cent unless the metric is absolute; what is below 1e-9 of it is rounding and says so."""
    if abs(value) < 1e-11:
        return "0"
    size = abs(value) * (1 if metric.absolute else 100)
    text = (f"{size:.2g}" if size < 99.5 else f"{size:.0f}") + ("" if metric.absolute else " %")
    return ("−" if value < 0 else "+" if signed else "") + text


def judgement(budget: Budget) -> str:
    """Of half-planes: is what is left over covered? Of real bodies: does an idealisation error stand out?"""
    if budget.resolved is None:
        return "not known: a term was not measured"
    if budget.half_planes:
        return "covered" if not budget.resolved else "not covered"
    return "resolved" if budget.resolved else "not resolved"


def cost(budget: ErrorBudget) -> str:
    """What the rungs were and what they took, in a sentence."""
    ladders = budget.ladders
    pairs = [rung for pair in ladders.penalty for rung in pair]
    rungs = {rung.label: rung for rung in (*ladders.mesh, *ladders.far_field, *pairs)}
    counts = ", ".join(
        f"{rung.label} ({rung.failure})" if rung.failure else f"{rung.label} ({rung.nodes} nodes, {rung.steps} steps)"
        for rung in rungs.values()
    )
    missing = "".join(f" The {term} ladder was not measured: {why}." for term, why in ladders.not_measured.items())
    return f"Run and budget took {budget.cost:.2f} times the CPU time of the run: {counts}.{missing}"


def honest_of(comparison: Comparison, metric: Metric) -> str:
    """Yes, no, or not assessed."""
    if comparison.budget is None or metric.key not in {one.metric.key for one in comparison.budget.budgets}:
        return "not assessed"
    return {True: "yes", False: "no", None: "not assessed"}[comparison.budget.budget(metric.key).honest]


def honesty(comparison: Comparison) -> bool | None:
    """Whether every stated uncertainty of the first table covers the known error; None where none was assessed."""
    found = [honest_of(comparison, metric) for metric in comparison.headlines]
    return None if set(found) == {"not assessed"} else "no" not in found


def content(budget: ErrorBudget) -> dict[str, Any]:
    """For comparison.json."""
    return {
        "cost": budget.cost,
        "words": cost(budget),
        "honest": budget.honest,
        "metrics": {one.metric.key: _metric(one) for one in budget.budgets},
    }


def _metric(budget: Budget) -> dict[str, Any]:
    return {
        "E": budget.total,
        "terms": {term.name: {**vars(term), "measured": term.measured} for term in budget.terms},
        "unexplained" if budget.half_planes else "idealisation": budget.rest,
        "u": budget.uncertainty,
        "resolved": budget.resolved,
        "honest": budget.honest,
        "verdict": judgement(budget),
    }
