"""Every metric of a comparison, in the order of the tables."""

from __future__ import annotations

from reports.definitions import DEFINITIONS
from reports.judging_tractions import tractions
from reports.judging_work import work
from reports.judging_zones import zones
from reports.verdicts import Metric, Pair


def judge(pair: Pair) -> tuple[Metric, ...]:
    """Every metric, the headlines first, in the order of their definitions."""
    order = list(DEFINITIONS)
    return tuple(sorted((*tractions(pair), *zones(pair), *work(pair)), key=lambda metric: order.index(metric.key)))
