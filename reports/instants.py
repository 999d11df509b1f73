"""Moved to reports.comparison."""

from reports.comparison.cycles import Event, events

__all__ = ["Event", "events"]
