"""Moved to reports.comparison."""

from reports.comparison.budget import Ladders, Rung, climb, coarser, mesh_ratio, without_steps

__all__ = ["Ladders", "Rung", "climb", "coarser", "mesh_ratio", "without_steps"]
