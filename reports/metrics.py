"""Moved to reports.comparison."""

from reports.comparison.metrics import Scales, compliance, norm, over, peak_place, scales, shares, spacing_at, worst_point

__all__ = ["Scales", "compliance", "norm", "over", "peak_place", "scales", "shares", "spacing_at", "worst_point"]
