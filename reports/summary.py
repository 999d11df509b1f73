"""Moved to reports.comparison."""

from reports.comparison.content import as_json, solution_content, strict

__all__ = ["as_json", "solution_content", "strict"]
