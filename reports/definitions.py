"""Moved to reports.comparison."""

from reports.comparison.metrics import METRICS as DEFINITIONS
from reports.comparison.metrics import markdown, name_of

__all__ = ["DEFINITIONS", "markdown", "name_of"]
