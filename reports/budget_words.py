"""Moved to reports.comparison."""

from reports.comparison.words import content, cost, heads, honest_of, honesty, judgement, narrow, rows, share

__all__ = ["content", "cost", "heads", "honest_of", "honesty", "judgement", "narrow", "rows", "share"]
