"""Moved to reports.comparison."""

from reports.comparison.metrics import LIGHT, Metric, Pair, Verdict, verdict_on, worst

__all__ = ["LIGHT", "Metric", "Pair", "Verdict", "verdict_on", "worst"]
