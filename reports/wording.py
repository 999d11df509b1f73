"""Moved to reports.comparison."""

from reports.comparison.words import (
    CLAIM,
    accuracy_of,
    beyond_theory,
    how_judged,
    lead,
    open_value_of,
    percent,
    question,
    sentence,
    standing,
    tolerance_of,
    uncertain_work,
    uncertainty_of,
    unit_of,
    value_of,
    verdict,
)

__all__ = [
    "CLAIM",
    "accuracy_of",
    "beyond_theory",
    "how_judged",
    "lead",
    "open_value_of",
    "percent",
    "question",
    "sentence",
    "standing",
    "tolerance_of",
    "uncertain_work",
    "uncertainty_of",
    "unit_of",
    "value_of",
    "verdict",
]
