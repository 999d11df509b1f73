"""Moved to reports.comparison."""

from reports.comparison.cycles import Cycle, instants, last_cycle, sample, sample_instants

__all__ = ["Cycle", "instants", "last_cycle", "sample", "sample_instants"]
