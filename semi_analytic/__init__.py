"""The half-plane engine: partial slip of any symmetric profile under any history of P and Q, exact to rounding."""

from semi_analytic.batch import Reason
from semi_analytic.damping import Hysteresis, compliance, hysteresis
from semi_analytic.letters import Event, event, events
from semi_analytic.question import FIELDS
from semi_analytic.solution import solve
from semi_analytic.sweeps import DissipationBatch, PeakBatch, dissipation, peak_dissipation

__all__ = [
    "FIELDS",
    "DissipationBatch",
    "Event",
    "Hysteresis",
    "PeakBatch",
    "Reason",
    "compliance",
    "dissipation",
    "event",
    "events",
    "hysteresis",
    "peak_dissipation",
    "solve",
]
