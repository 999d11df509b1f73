"""Faults of the file, not of the model: a sign, two columns swapped, a factor. They act on the reference's arrays alone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reports.scoring.diagnosis_discrepancy import Discrepancy
from reports.scoring.diagnosis_hypothesis import Hypothesis

# A fitted factor counts as the round one that it is near: a mesh does not move a resultant by more.
NEAR = 0.02
# A factor of a hundred or more is one of units even this far from the round one: what is left of it is another fault.
NEAR_OF_UNITS = 0.25
# Below this a factor is no fault of a file; modulus, radius or loads explain it better.
LEAST_FACTOR = 0.01
# No elastic contact has another pressure and the same width and shear, so a factor of p alone has no rival.
LEAST_OF_PRESSURE = 1e-3


def array_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """Every fault of the file that the discrepancy may have."""
    p, q = what.expected
    if np.any(q):
        yield Hypothesis("shear_sign", (p, -q), mend=lambda found: (found[0], -found[1]))
        yield Hypothesis("swapped", (q, p), mend=lambda found: (found[1], found[0]))
        yield Hypothesis("frictionless", (p, np.zeros_like(q)), {"shear left": _size(what, 1)})
    yield Hypothesis("pressure_sign", (-p, q), mend=lambda found: (-found[0], found[1]))
    yield from _factor(what)
    if np.any(q):
        yield from _pressure_factor(what)


def _size(what: Discrepancy, which: int) -> float:
    """Root mean square of p or q found over that expected."""
    found, expected = (np.sum(what.weight * np.square(tractions[which])) for tractions in (what.found, what.expected))
    return float(np.sqrt(found / expected)) if expected > 0 else float("inf")


def _factor(what: Discrepancy) -> Iterator[Hypothesis]:
    """Both tractions k times too large, places and widths right: k = <found, expected>/<expected, expected>.

    Widths set it apart from loads k times too large: no elastic contact carries k times the load on the same width.
    """
    scales = what.comparison.scales
    units = (1 / scales.pressure, 1 / scales.shear)
    product = [
        sum(float(np.sum(what.weight * (a * b * unit**2))) for a, b, unit in zip(one, what.expected, units, strict=True))
        for one in (what.found, what.expected)
    ]
    k = product[0] / product[1]
    if k <= 0 or abs(k - 1) < LEAST_FACTOR:
        return
    order = round(np.log10(k))
    off = abs(k / 10.0**order - 1)
    unit = order != 0 and off < (NEAR_OF_UNITS if abs(order) >= 2 else NEAR)
    factor = 10.0**order if unit and off >= NEAR else k
    yield Hypothesis(
        "units" if unit else "traction_factor",
        (factor * what.expected[0], factor * what.expected[1]),
        {"factor": 10.0**order if unit else float(k)},
        mend=lambda found: (found[0] / factor, found[1] / factor),
    )


def _pressure_factor(what: Discrepancy) -> Iterator[Hypothesis]:
    """The pressure k times too large, the shear right."""
    p, q = what.expected
    k = float(np.sum(what.weight * what.found[0] * p) / np.sum(what.weight * p**2))
    if k > 0 and abs(k - 1) > LEAST_OF_PRESSURE:
        yield Hypothesis("pressure_factor", (k * p, q), {"factor": k}, mend=lambda found: (found[0] / k, found[1]))
