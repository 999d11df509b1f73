"""The half-plane engine: partial slip of any symmetric profile under any history of P and Q, exact to rounding."""

from semi_analytic.question import FIELDS
from semi_analytic.solution import solve

__all__ = ["FIELDS", "solve"]
