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

from reports.units import PythonNumbers, minus
from scenes import Estimate
from scenes.body_effects import ZERO_ESTIMATE

# The main cause is named where the unexplained part is at most a third of it, and where it is at
# least half of the sum of the sizes of all parts.
_LARGEST_UNEXPLAINED_SHARE = 1 / 3
_LEAST_SHARE_OF_MAIN_CAUSE = 1 / 2
UNEXPLAINED = "what is left"
MESH_AND_STEPS = "mesh and steps"


def in_percent(relative_change: float) -> str:
    """A relative change in per cent with two decimals and its sign; "0.00" has no sign."""
    digits = f"{100 * relative_change:+.2f}"
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
    uncertainty_in_percent = max(100 * change.uncertainty, 0.01)
    return f"{percent_in_words} ± {uncertainty_in_percent:.2f} %"


class ErrorPart(NamedTuple):
    """One part of the difference of W between theory and finite elements, with its cause.

    Attributes
    ----------
    cause
        in words
    change
        the part over theory's W, with its uncertainty
    sum_before
        sum of the parts before it, where its bar in the figure starts
    """

    cause: str
    change: Estimate
    sum_before: float


@dataclass(frozen=True)
class Why(PythonNumbers):
    """The difference of W between finite elements and half-plane theory, split.

    Attributes
    ----------
    difference
        E = finite elements/theory − 1 in W, and its uncertainty
    parts
        cause, a property of the bodies -> its part of E, in the order in which they are taken;
        empty where the difference is not split
    numerical_part
        the part of mesh and load steps by the error budget; its uncertainty is in that of E
    reason_not_split
        why the difference is not split; empty where it is
    """

    difference: Estimate
    parts: Mapping[str, Estimate] = field(default_factory=dict)
    numerical_part: Estimate = ZERO_ESTIMATE
    reason_not_split: str = ""

    @property
    def unexplained_part(self) -> Estimate:
        """The part of the difference that no cause explains. Its uncertainty is that of all causes
        and of the difference, which has that of mesh and steps.
        """
        explained_part = sum(part.value for part in self.parts.values())
        uncertainty_of_parts = sum(part.uncertainty for part in self.parts.values())
        return Estimate(
            self.difference.value - explained_part - self.numerical_part.value,
            self.difference.uncertainty + uncertainty_of_parts,
        )

    @property
    def is_explained(self) -> bool | None:
        """Whether the unexplained part is within its uncertainty; None where that is not known."""
        if math.isnan(self.unexplained_part.uncertainty):
            return None
        return abs(self.unexplained_part.value) <= self.unexplained_part.uncertainty

    @property
    def all_parts(self) -> list[ErrorPart]:
        """The parts of the bodies, the unexplained part, and that of mesh and steps; their sum is
        E, the difference of W. Empty where the difference is not split.

        A part has its cause in words, its size over theory's W with uncertainty, and the sum of the
        parts before it.
        """
        if not self.parts:
            return []
        # UNEXPLAINED, MESH_AND_STEPS: causes in words, "what is left" and "mesh and steps"
        change_by_cause = {
            **self.parts,
            UNEXPLAINED: self.unexplained_part,
            MESH_AND_STEPS: self.numerical_part,
        }
        all_parts = []
        sum_before = 0.0
        for cause, change in change_by_cause.items():
            all_parts.append(ErrorPart(cause, change, sum_before))
            sum_before += change.value
        return all_parts

    @property
    def main_cause(self) -> str:
        """In words, the cause of most of the difference of W between finite elements and theory.

        "" where the difference is not split or not resolved, or where the largest part has the
        other sign or is not resolved. "" too where that part is less than half of the sum of the
        sizes of all parts, or the unexplained part more than a third of it. Resolved: larger than
        two uncertainties. `parts` maps a cause to its part of the difference with uncertainty.

        >>> parts = {"tilt": Estimate(0.03, 0.001), "strain": Estimate(-0.004, 0.001)}
        >>> Why(Estimate(0.027, 0.001), parts).main_cause
        'tilt'
        >>> Why(Estimate(0.07, 0.001), parts).main_cause  # most of it has another cause
        ''
        """
        if not self.parts:
            return ""
        cause = max(self.parts, key=lambda name: abs(self.parts[name].value))
        largest_part = self.parts[cause]
        size = abs(largest_part.value)
        sum_of_sizes = sum(abs(part.value) for part in self.parts.values())
        is_resolved = abs(self.difference.value) > 2 * self.difference.uncertainty
        has_same_sign = math.copysign(1.0, largest_part.value) == math.copysign(
            1.0, self.difference.value
        )
        is_main = (
            size >= _LEAST_SHARE_OF_MAIN_CAUSE * sum_of_sizes
            and size > 2 * largest_part.uncertainty
        )
        is_mostly_explained = abs(self.unexplained_part.value) <= _LARGEST_UNEXPLAINED_SHARE * size
        return cause if is_resolved and has_same_sign and is_main and is_mostly_explained else ""

    @property
    def unexplained_in_percent(self) -> str:
        """The part of the difference that no cause explains, in per cent with its uncertainty."""
        return percent_of(self.unexplained_part)

    @property
    def cause_in_percent(self) -> str:
        """The part of the main cause, in per cent of theory's W without its uncertainty."""
        return percent_of(Estimate(self.parts[self.main_cause].value))

    @property
    def sentence(self) -> str:
        """A sentence: the parts in per cent, or why the difference is not split."""
        if not self.parts:
            return f"Why theory errs is not split: {self.reason_not_split}."
        cells = [f"{cause} {percent_of(change)}" for cause, change, _ in self.all_parts]
        return f"Why (finite elements/theory − 1 in W): {', '.join(cells)}."

    def rows(self) -> list[tuple[str, str]]:
        """Rows (cause, part in per cent of theory's W) of a table, with E in the last row."""
        rows = [(cause, percent_of(change)) for cause, change, _ in self.all_parts]
        return [*rows, ("finite elements/theory − 1", percent_of(self.difference))]

    def content(self) -> dict[str, Any]:
        """The entry "why" of comparison.json: the difference of the dissipation W between finite
        elements and theory and the part of each cause, over theory's W; the main cause; and why the
        difference was not split, if so.
        """
        # in the order in which they lead from theory to finite elements; empty where not split
        steps_from_theory = [
            {"cause": cause, "value": change.value, "uncertainty": change.uncertainty}
            for cause, change, _ in self.all_parts
        ]
        return {
            "total": self.difference.value,
            "uncertainty": self.difference.uncertainty,
            "steps": steps_from_theory,
            "main_cause": self.main_cause or None,
            "explained": self.is_explained if steps_from_theory else None,
            "not_split": self.reason_not_split or None,
        }
