"""Moved to reports.comparison."""

from reports.comparison.budget import ROUNDING, Budget, ErrorBudget, Term, error_budget, with_budget

__all__ = ["ROUNDING", "Budget", "ErrorBudget", "Term", "error_budget", "with_budget"]
