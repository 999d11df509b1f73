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

# A cause is named where what is left is less than this share of it, and where it is at least this
# share of the sizes of all parts.
_LEFT_OF_A_CAUSE = 1 / 3
_MAIN_SHARE = 1 / 2
LEFT = "what is left"
NUMERICAL = "mesh and steps"


def in_percent(share: float) -> str:
    """A share in per cent, two digits behind the point, with its sign unless these are zeros."""
    digits = f"{100 * share:+.2f}"
    return "0.00" if float(digits) == 0 else minus(digits)


def percent_of(change: Estimate) -> str:
    """A relative change in per cent with two decimals and its uncertainty, 0.01 at least; without
    one where that is 0 or unknown.

    >>> percent_of(Estimate(-0.0200, 0.00021)), percent_of(Estimate(0.0004))
    ('−2.00 ± 0.02 %', '+0.04 %')
    """
    percent_in_words = in_percent(change.value)
    if not change.uncertainty or math.isnan(change.uncertainty):
        return f"{percent_in_words} %"
    uncertainty = max(100 * change.uncertainty, 0.01)
    return f"{percent_in_words} ± {uncertainty:.2f} %"


class Step(NamedTuple):
    """A step of the way from theory to the finite elements.

    Attributes
    ----------
    words
        what makes it
    change
        share of theory's W, with its uncertainty
    start
        sum of the steps before
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
        E and its uncertainty
    parts
        of the bodies, by what makes them, in the order in which they are taken; empty where the
        difference is not split
    numerical
        known terms of the budget, mesh and steps; their uncertainty is in that of E
    not_split
        why it is not; empty where it is
    """

    total: Estimate
    parts: Mapping[str, Estimate] = field(default_factory=dict)
    numerical: Estimate = ZERO
    not_split: str = ""

    @property
    def left(self) -> Estimate:
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
        """Whether what is left is within its uncertainty; None where that is not known."""
        if math.isnan(self.left.uncertainty):
            return None
        return abs(self.left.value) <= self.left.uncertainty

    @property
    def steps(self) -> list[Step]:
        """The parts, what is left, mesh and steps; their sum is E. None where it is not split."""
        if not self.parts:
            return []
        changes = {**self.parts, LEFT: self.left, NUMERICAL: self.numerical}
        steps = []
        start = 0.0
        for words, change in changes.items():
            steps.append(Step(words, change, start))
            start += change.value
        return steps

    @property
    def main_cause(self) -> str:
        """In words, what makes most of the difference of W between finite elements and theory; ""
        where no cause is known to.

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
        same_sign = math.copysign(1.0, change.value) == math.copysign(1.0, self.total.value)
        is_main = size >= _MAIN_SHARE * all_sizes and size > 2 * change.uncertainty
        is_explained = abs(self.left.value) <= _LEFT_OF_A_CAUSE * size
        return cause if is_resolved and same_sign and is_main and is_explained else ""

    @property
    def left_in_percent(self) -> str:
        """The part of the difference that no cause explains, in per cent with its uncertainty."""
        return percent_of(self.left)

    @property
    def cause_in_percent(self) -> str:
        """What the main cause makes of W, in per cent without its uncertainty, for a headline."""
        return percent_of(Estimate(self.parts[self.main_cause].value))

    @property
    def sentence(self) -> str:
        """The steps in per cent, or why there are none."""
        if not self.parts:
            return f"Why theory errs is not split: {self.not_split}."
        cells = [f"{words} {percent_of(change)}" for words, change, _ in self.steps]
        return f"Why (finite elements/theory − 1 in W): {', '.join(cells)}."

    def rows(self) -> list[tuple[str, str]]:
        """Cells of a table: what makes it, its share of theory's W; E below."""
        rows = [(words, percent_of(change)) for words, change, _ in self.steps]
        return [*rows, ("finite elements/theory − 1", percent_of(self.total))]

    def content(self) -> dict[str, Any]:
        """The entry "why" of comparison.json: the difference of the dissipation W between finite
        elements and theory, the change that each cause makes, all as shares of theory's W, the main
        cause, and why the difference was not split, if so.
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
