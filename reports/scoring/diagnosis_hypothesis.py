"""A fault with its fitted figure and what it predicts; and the fit of one figure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from reports.scoring.diagnosis_discrepancy import Discrepancy, Tractions
from scenes import InputError, Scene


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One fault, fitted.

    Attributes
    ----------
    fault : its key, see `diagnosis_words.FAULTS`
    predicted : tractions of a result that has just this fault
    figures : what was fitted or measured, by name
    mend : takes the fault out of the tractions found; None where the next fault is looked for beyond what this one predicts
    scene : the question that `predicted` is the exact answer of; None where there is no such scene
    """

    fault: str
    predicted: Tractions
    figures: Mapping[str, float] = field(default_factory=dict)
    mend: Callable[[Tractions], Tractions] | None = None
    scene: Scene | None = None

    def mended(self, what: Discrepancy) -> Discrepancy:
        """What is left to explain without this fault."""
        return what.beyond(self.predicted, self.scene) if self.mend is None else what.seen_as(self.mend(what.found))


def possible(predict: Callable[[float], Tractions]) -> Callable[[float], Tractions | None]:
    """`predict`, None where the scene with that figure has no solution (gross sliding, separation)."""

    def tried(figure: float) -> Tractions | None:
        try:
            return predict(figure)
        except InputError:
            return None

    return tried


def fitted(
    what: Discrepancy, predict: Callable[[float], Tractions], tries: tuple[float, ...], rounds: int = 12
) -> tuple[float, Tractions] | None:
    """The figure that leaves least of the discrepancy, and its prediction; None where no try has a solution.

    The best of `tries` (ascending), then `rounds` parabolas through the best and its neighbours, each keeping the best three: the
    discrepancy left is a square, so a parabola is its own shape near the least.
    """
    solve = possible(predict)
    seen: dict[float, tuple[float, Tractions]] = {}

    def look(figure: float) -> None:
        if (tractions := solve(figure)) is not None:
            seen[figure] = what.apart(tractions), tractions

    for figure in tries:
        look(figure)
    for _ in range(rounds if len(seen) > 2 else 0):
        figure = _lowest(sorted((figure, left) for figure, (left, _) in seen.items()))
        if any(abs(figure - other) <= 1e-4 * np.ptp(tries) for other in seen):
            break
        look(figure)
    if not seen:
        return None
    best = min(seen, key=lambda figure: seen[figure][0])
    return best, seen[best][1]


def _lowest(seen: list[tuple[float, float]]) -> float:
    """Lowest place of the parabola through the best and its two neighbours, inside these."""
    at = int(np.clip(np.argmin([left for _, left in seen]), 1, len(seen) - 2))
    (a, left), (b, middle), (c, right) = seen[at - 1 : at + 2]
    down, up = (middle - left) / (b - a), (right - middle) / (c - b)
    bend = (up - down) / (c - a)
    inside = (b + a) / 2 - down / (2 * bend) if np.isfinite(bend) and bend > 0 else (b + c) / 2
    return float(np.clip(inside, a + 0.05 * (b - a), c - 0.05 * (c - b)))
