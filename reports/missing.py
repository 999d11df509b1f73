"""Moved to reports.comparison."""

from reports.comparison.laws import DERIVED, derived
from reports.comparison.metrics import WHOLE_CYCLE, missing

__all__ = ["DERIVED", "derived", "WHOLE_CYCLE", "missing"]
