"""The verdict on an error: what it and its uncertainty say of a tolerance."""

from __future__ import annotations

import math
from enum import StrEnum


class Verdict(StrEnum):
    """Whether an error is within a tolerance, by its uncertainty."""

    WITHIN = "within"
    OUTSIDE = "outside"
    UNDECIDED = "undecided"


def verdict_on(error: float, tolerance: float, uncertainty: float | None = None) -> Verdict:
    """Whether the size of an error E lies within `tolerance`, both in one unit.

    Within if |E| + u <= tolerance, outside if |E| - u > tolerance, else undecided. Where no
    uncertainty u is known, |E| alone decides. An error that is not finite is outside; an
    uncertainty that is not finite decides nothing.

    >>> print(verdict_on(-0.016, 0.05), verdict_on(-0.016, 0.05, 0.75), verdict_on(0.9, 0.05, 0.75))
    within undecided outside
    """
    if not math.isfinite(error):
        return Verdict.OUTSIDE
    known_uncertainty = 0.0 if uncertainty is None else uncertainty
    if abs(error) + known_uncertainty <= tolerance:
        return Verdict.WITHIN
    if abs(error) - known_uncertainty > tolerance:
        return Verdict.OUTSIDE
    return Verdict.UNDECIDED
