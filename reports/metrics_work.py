"""Moved to reports.comparison."""

from reports.comparison.metrics import loop_work, normal_work

__all__ = ["loop_work", "normal_work"]
