"""Why half-plane theory errs in the dissipation W for the bodies of a scene: the difference of the
finite elements, split by what makes it.

    E = parts of the bodies + what is left + mesh and steps

E is finite elements/theory - 1, as in the first table. The parts are those of corrected theory
(`reports.advising_by_numbers`), in a stated order; mesh and steps are the terms of the error
budget. What is left is the rest, so that the sum ends at E by construction: its size against its
uncertainty, that of the parts and of E together, says whether the parts explain the difference.

Corrected theory shares mesher and elements with the finite elements. It explains the difference,
and is no check of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from reports.python_numbers import PythonNumbers
from reports.units import minus
from scenes import Estimate
from scenes.body_effects import ZERO

# The main cause is named where the unexplained part is at most a third of it, and where it is at
# least half of the sum of the sizes of all parts.
_LARGEST_UNEXPLAINED_SHARE = 1 / 3
_LEAST_SHARE_OF_MAIN_CAUSE = 1 / 2
LEFT = "what is left"
NUMERICAL = "mesh and steps"


def in_percent(share: float) -> str:
    """A relative change in per cent with two decimals and its sign; "0.00" has no sign."""
    digits = f"{100 * share:+.2f}"
    return "0.00" if float(digits) == 0 else minus(digits)


def percent_of(change: Estimate) -> str:
    """A relative change in per cent with two decimals, and its uncertainty, at least 0.01 %.
    Without the uncertainty where that is 0 or unknown.

    >>> percent_of(Estimate(-0.0200, 0.00021)), percent_of(Estimate(0.0004))
    ('−2.00 ± 0.02 %', '+0.04 %')
    """
    percent_in_words = in_percent(change.value)
    if not change.uncertainty or math.isnan(change.uncertainty):
        return f"{percent_in_words} %"
    uncertainty = max(100 * change.uncertainty, 0.01)
    return f"{percent_in_words} ± {uncertainty:.2f} %"


class Step(NamedTuple):
    """One part of the difference of W between theory and finite elements, with its cause.

    Attributes
    ----------
    words
        the cause
    change
        the part over theory's W, with its uncertainty
    start
        sum of the parts before, where its bar in the figure starts
    """

    words: str
    change: Estimate
    start: float


@dataclass(frozen=True)
class Why(PythonNumbers):
    """The difference of W between finite elements and half-plane theory, split.

    Attributes
    ----------
    total
        E = finite elements/theory − 1 in W, and its uncertainty
    parts
        cause, a property of the bodies -> its part of E, in the order in which they are taken;
        empty where the difference is not split
    numerical
        the part of mesh and load steps by the error budget; its uncertainty is in that of E
    not_split
        why the difference is not split; empty where it is
    """

    total: Estimate
    parts: Mapping[str, Estimate] = field(default_factory=dict)
    numerical: Estimate = ZERO
    not_split: str = ""

    @property
    def unexplained(self) -> Estimate:
        """The part of the difference that no cause explains. Its uncertainty is that of all causes
        and of the difference, which has that of mesh and steps.
        """
        explained = sum(part.value for part in self.parts.values())
        uncertainty = sum(part.uncertainty for part in self.parts.values())
        return Estimate(
            self.total.value - explained - self.numerical.value,
            self.total.uncertainty + uncertainty,
        )

    @property
    def explains(self) -> bool | None:
        """Whether the unexplained part is within its uncertainty; None where that is not known."""
        if math.isnan(self.unexplained.uncertainty):
            return None
        return abs(self.unexplained.value) <= self.unexplained.uncertainty

    @property
    def steps(self) -> list[Step]:
        """The parts of the bodies, the unexplained part, and that of mesh and steps; their sum is
        E. Empty where the difference is not split.
        """
        if not self.parts:
            return []
        changes = {**self.parts, LEFT: self.unexplained, NUMERICAL: self.numerical}
        steps = []
        start = 0.0
        for words, change in changes.items():
            steps.append(Step(words, change, start))
            start += change.value
        return steps

    @property
    def main_cause(self) -> str:
        """In words, the cause of most of the difference of W between finite elements and theory.

        "" where the difference is not split or not resolved, where the largest part has the other
        sign or is not resolved, where it is less than half of all parts, or where more than a third
        of it is unexplained.

        >>> parts = {"tilt": Estimate(0.03, 0.001), "strain": Estimate(-0.004, 0.001)}
        >>> Why(Estimate(0.027, 0.001), parts).main_cause
        'tilt'
        >>> Why(Estimate(0.07, 0.001), parts).main_cause  # most of it has another cause
        ''
        """
        if not self.parts:
            return ""
        cause = max(self.parts, key=lambda name: abs(self.parts[name].value))
        change = self.parts[cause]
        size = abs(change.value)
        all_sizes = sum(abs(part.value) for part in self.parts.values())
        is_resolved = abs(self.total.value) > 2 * self.total.uncertainty
        has_same_sign = math.copysign(1.0, change.value) == math.copysign(1.0, self.total.value)
        is_main = size >= _LEAST_SHARE_OF_MAIN_CAUSE * all_sizes and size > 2 * change.uncertainty
        is_explained = abs(self.unexplained.value) <= _LARGEST_UNEXPLAINED_SHARE * size
        return cause if is_resolved and has_same_sign and is_main and is_explained else ""

    @property
    def left_in_percent(self) -> str:
        """The part of the difference that no cause explains, in per cent with its uncertainty."""
        return percent_of(self.unexplained)

    @property
    def cause_in_percent(self) -> str:
        """The part of the main cause, in per cent of theory's W without its uncertainty."""
        return percent_of(Estimate(self.parts[self.main_cause].value))

    @property
    def sentence(self) -> str:
        """A sentence: the parts in per cent, or why the difference is not split."""
        if not self.parts:
            return f"Why theory errs is not split: {self.not_split}."
        cells = [f"{words} {percent_of(change)}" for words, change, _ in self.steps]
        return f"Why (finite elements/theory − 1 in W): {', '.join(cells)}."

    def rows(self) -> list[tuple[str, str]]:
        """Rows (cause, part in per cent of theory's W) of a table, with E in the last row."""
        rows = [(words, percent_of(change)) for words, change, _ in self.steps]
        return [*rows, ("finite elements/theory − 1", percent_of(self.total))]

    def content(self) -> dict[str, Any]:
        """The entry "why" of comparison.json: the difference of the dissipation W between finite
        elements and theory and the part of each cause, over theory's W; the main cause; and why the
        difference was not split, if so.
        """
        steps = [
            {"cause": cause, "value": change.value, "uncertainty": change.uncertainty}
            for cause, change, _ in self.steps
        ]
        return {
            "total": self.total.value,
            "uncertainty": self.total.uncertainty,
            "steps": steps,
            "main_cause": self.main_cause or None,
            "explained": self.explains if steps else None,
            "not_split": self.not_split or None,
        }
