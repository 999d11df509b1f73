"""The discrepancy of a result as one vector, and how much of it a fault would explain.

Every fault is a hypothesis: "the result is the reference, but for this". A hypothesis predicts tractions p*, q* on the result's
points and instants, its one or two free figures fitted by least squares, and explains the share

    e = 1 - |found - predicted|^2 / |found - expected|^2

of the discrepancy. The norm is that of the scaled tractions p/p_ref and q/(f p_ref) over x and time, so that a pressure and a shear
off by the same share of their scales count alike. A prediction is taken rather than a linear mode, since large faults are not
linear: a sign, a factor of a thousand, a contact half as wide.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.comparison import Comparison
from reports.comparison.metrics import Verdict, norm, over, shares, verdict_on
from scenes import Scene

Array = NDArray[np.float64]
Tractions = tuple[Array, Array]
"""Pressure and shear, (k, n) each [stress]."""

# A steady cycle has some ten features (turning points, ends of full stick); three instants to each are enough to tell faults apart.
MOST_INSTANTS = 32


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """What is to be explained: some instants of the last cycle, all points.

    Attributes
    ----------
    comparison : where it was taken from
    rows : (k,), the instants taken, of the last cycle's
    expected, found : pressure and shear of reference and result, (k, n) each; where the result has no number, the reference's
    weight : (k, n) of the squares, 0 where the result has no number
    missing : share of the result's tractions that are no numbers
    scene : the question that `expected` answers: the comparison's, or that with a fault in it that was found before
    exact : whether `expected` is half-plane theory of `scene`
    sheared : whether the shear counts
    """

    comparison: Comparison
    rows: NDArray[np.intp]
    expected: Tractions
    found: Tractions
    weight: Array
    missing: float
    scene: Scene
    exact: bool
    sheared: bool = True

    @property
    def x(self) -> Array:
        """(n,) [length]."""
        return self.comparison.found.x

    @property
    def time(self) -> Array:
        """(k,) of the load path."""
        return self.comparison.found.time[self.rows]

    @property
    def fraction(self) -> Array:
        """(k,) of the cycle."""
        return self.comparison.found.fraction[self.rows]

    @property
    def size(self) -> float:
        """Root of the mean square of found less expected, over that of expected."""
        return float(np.sqrt(self.apart(self.expected) / self._squares(self.expected)))

    @property
    def of_pressure(self) -> Discrepancy:
        """That of the pressure alone: between like bodies it knows nothing of friction, and tells the rest apart."""
        return replace(self, sheared=False)

    def _squares(self, tractions: Tractions) -> float:
        scales = self.comparison.scales
        pressure, shear = tractions
        squares = np.square(pressure / scales.pressure) + self.sheared * np.square(shear / scales.shear)
        return float(np.sum(self.weight * squares))

    def apart(self, predicted: Tractions) -> float:
        """Weighted square of found less predicted; infinite where the prediction holds a NaN."""
        value = self._squares((self.found[0] - predicted[0], self.found[1] - predicted[1]))
        return value if np.isfinite(value) else float("inf")

    def explained(self, predicted: Tractions) -> float:
        """Share of the discrepancy that `predicted` explains: 1 is all, 0 none, below 0 makes it worse."""
        whole = self.apart(self.expected)
        return 1 - self.apart(predicted) / whole if whole > 0 else 0.0

    def errors(self) -> tuple[float, float]:
        """||p - p_ref||/||p_ref|| and ||q - q_ref||/(f ||p_ref||) at the worst of the instants."""
        friction = self.comparison.scales.friction
        size = norm(self.x, self.expected[0])
        p, q = (norm(self.x, found - expected) for found, expected in zip(self.found, self.expected, strict=True))
        return float(np.nanmax(over(p, size), initial=0.0)), float(np.nanmax(over(q, friction * size), initial=0.0))

    def within(self, times: float = 1.0) -> bool:
        """Whether both errors are within so many tolerances of the scene."""
        limits = [times * (self.comparison.scene.tolerances.limit(key) or 0.0) for key in ("pressure", "shear")]
        return all(verdict_on(*pair) is Verdict.WITHIN for pair in zip(self.errors(), limits, strict=True))

    def beyond(self, predicted: Tractions, scene: Scene | None) -> Discrepancy:
        """What is left to explain beyond a fault that predicts this; `scene`: the question whose exact answer that is, if any."""
        if scene is None or not self.exact:
            return replace(self, expected=predicted, exact=False)
        return replace(self, expected=predicted, scene=scene)

    def seen_as(self, found: Tractions) -> Discrepancy:
        """The same with other tractions found."""
        return replace(self, found=found)


def discrepancy(comparison: Comparison) -> Discrepancy | None:
    """The discrepancy of `comparison`; None where the result has no instant with a contact or not one number."""
    usable = np.flatnonzero(comparison.judged if comparison.judged.any() else comparison.touching)
    if not len(usable):
        return None
    rows = usable[np.unique(np.linspace(0, len(usable) - 1, min(len(usable), MOST_INSTANTS)).round().astype(int))]
    expected = comparison.expected.pressure[rows], comparison.expected.shear[rows]
    found = comparison.found.pressure[rows], comparison.found.shear[rows]
    known = np.isfinite(found[0]) & np.isfinite(found[1]) & np.isfinite(expected[0]) & np.isfinite(expected[1])
    if not known.any():
        return None
    weight = known * shares(comparison.found.time[rows])[:, None] * shares(comparison.found.x)
    expected = np.nan_to_num(expected[0]), np.nan_to_num(expected[1])
    exact = comparison.reference.engine == "semi_analytic"
    filled = np.where(known, found[0], expected[0]), np.where(known, found[1], expected[1])
    return Discrepancy(comparison, rows, expected, filled, weight / weight.sum(), float(1 - known.mean()), comparison.scene, exact)
