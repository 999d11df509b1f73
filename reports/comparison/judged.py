"""A pair with its metrics, laws and notes, and the verdict on all of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from reports.comparison.laws import Certificate
from reports.comparison.metrics import Metric
from reports.comparison.pairs import Pair
from reports.comparison.verdicts import Verdict
from reports.comparison.why import Why
from scenes import Scene


@dataclass(frozen=True, eq=False)
class JudgedPair(Pair):
    """Reference and result, every metric of both with its verdict, and the laws that each obeys.

    Attributes
    ----------
    metrics
        in the order of the table, each with its value, uncertainty and verdict
    reference_certificates, result_certificates
        the laws of contact that each solution was checked for, with its largest violation
    notes
        sentences that a reader must not miss
    why
        the difference of the dissipation split by its causes; None where that was not asked for
    """

    metrics: tuple[Metric, ...]
    reference_certificates: tuple[Certificate, ...]
    result_certificates: tuple[Certificate, ...]
    notes: tuple[str, ...]
    why: Why | None = field(default=None, kw_only=True)

    @property
    def scene(self) -> Scene:
        """The scene that both solutions answer."""
        return self.result.scene

    @property
    def verdict(self) -> Verdict | None:
        """Verdict on the whole comparison: outside if one metric is outside, else undecided if one
        is undecided, else within. None where no metric is judged.
        """
        verdicts = {metric.verdict for metric in self.metrics}
        for candidate in (Verdict.OUTSIDE, Verdict.UNDECIDED, Verdict.WITHIN):
            if candidate in verdicts:
                return candidate
        return None

    @property
    def accurate(self) -> bool:
        """Whether every metric that is judged is within its tolerance: undecided counts as outside,
        nothing to judge as within.
        """
        return self.verdict in (Verdict.WITHIN, None)

    @property
    def admissible(self) -> bool:
        """Whether both solutions obey every law of contact that was checked."""
        return all(
            check.holds for check in (*self.reference_certificates, *self.result_certificates)
        )

    @property
    def unscored(self) -> tuple[Metric, ...]:
        """The metrics with a tolerance and no value, since a solution lacks a field they need."""
        return tuple(
            metric for metric in self.metrics if metric.lacks_field and metric.tolerance is not None
        )

    @property
    def passed(self) -> bool:
        """Accurate and admissible, with a value for every metric that has a tolerance."""
        return self.accurate and self.admissible and not self.unscored

    @property
    def headlines(self) -> tuple[Metric, ...]:
        """The metrics of the first table, those with absolute values."""
        return tuple(metric for metric in self.metrics if metric.headline)

    @property
    def others(self) -> tuple[Metric, ...]:
        """The metrics of the second table."""
        return tuple(metric for metric in self.metrics if not metric.headline)

    def metric(self, key: str) -> Metric:
        """The metric of that key; KeyError for an unknown one."""
        return {metric.key: metric for metric in self.metrics}[key]
