"""Moved to reports.comparison."""

from reports.comparison.convergence import (
    Extrapolation,
    GridConvergence,
    Ladder,
    extrapolate,
    grid_convergence,
    kind_of,
    observed_order,
)

__all__ = ["Extrapolation", "GridConvergence", "Ladder", "extrapolate", "grid_convergence", "kind_of", "observed_order"]
