"""Moved to reports.comparison."""

from reports.comparison.expected import HEADS, Finding, check, content, measure, rows, scale

__all__ = ["HEADS", "Finding", "check", "content", "measure", "rows", "scale"]
