"""What the rows of a result show before a cause is looked for, step by step, each with its number:
what was read, equilibrium, resolution, laws, shape.

# notation: p pressure, q shear, f friction coefficient, P and Q loads, p_ref and a_ref scales
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reports.comparison import Comparison
from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy, discrepancy_of
from reports.units import minus
from scenes import SLIP_FORWARD, SLIP_REVERSE
from scenes.array_types import Array

# Of P, or of f P: a sum nearer to its load excludes another load, thickness or unit.
_BALANCED = 0.01
# Of its unit: less is round-off.
_ROUND_OFF = 1e-10
# Standard deviations of the scatter, of which it makes as much at one of many points.
_BY_SCATTER = 5.0


@dataclass(frozen=True)
class Step:
    """One step of the evidence.

    Attributes
    ----------
    name
        of the step
    words
        what was measured
    """

    name: str
    words: str

    @property
    def sentence(self) -> str:
        """Name and measure."""
        return f"{self.name}: {self.words}"


def evidence(comparison: Comparison) -> tuple[Step, ...]:
    """What a result shows about itself and beside the reference, in five steps, each with its title
    and a sentence: what was read, equilibrium, resolution, laws of contact, shape. Empty for a
    result without a contact.
    """
    discrepancy = discrepancy_of(comparison)
    if discrepancy is None:
        return ()
    return (
        Step("What was read", _reading(comparison)),
        Step("Equilibrium", "; ".join(_equilibrium(discrepancy))),
        Step("Resolution", "; ".join(_resolution(discrepancy))),
        Step("Laws", "; ".join(_laws(discrepancy))),
        Step("Shape", "; ".join(_shape(discrepancy))),
    )


def _reading(comparison: Comparison) -> str:
    """In words which tractions a result has, at how many points and instants, and their range."""
    result_cycle = comparison.result_cycle
    fields_in_words = "pressure alone"
    if not np.isnan(result_cycle.shear).all():
        fields_in_words = "pressure and shear"
    if np.isfinite(result_cycle.slip).any():
        fields_in_words += ", slip"
    return (
        f"{fields_in_words} at {len(result_cycle.x)} points from x ="
        f" {minus(f'{result_cycle.x[0]:.4g}')} to"
        f" {minus(f'{result_cycle.x[-1]:.4g}')} and {len(result_cycle.time)} instants of the"
        " last cycle"
    )


def _equilibrium(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on the sums of the tractions over x beside P, Q and the moment, at the loaded
    instants. `discrepancy` holds the tractions of result and reference.
    """
    is_loaded = discrepancy.loaded
    if not is_loaded.any():
        return
    x = discrepancy.x
    sum_of_pressure = np.trapezoid(discrepancy.result_tractions[PRESSURE], x, axis=1)[is_loaded]
    normal_load = discrepancy.normal_load[is_loaded]
    ratio = discrepancy.resultant_ratio
    sum_in_words = (
        f"the sum of p is {ratio:.4g} P ({_range(sum_of_pressure / normal_load)} by instants)"
    )
    if abs(ratio - 1) < _BALANCED:
        sum_in_words += ", so that no load, thickness or unit of it is wrong"
    yield sum_in_words
    friction = discrepancy.comparison.scene.friction.coefficient
    if discrepancy.sheared and friction:
        sum_of_shear = np.trapezoid(discrepancy.result_tractions[SHEAR], x, axis=1)[is_loaded]
        tangential_load = discrepancy.comparison.reference_cycle.tangential_load[discrepancy.rows][
            is_loaded
        ]
        largest_difference = float(
            np.max(np.abs(sum_of_shear - tangential_load) / (friction * normal_load))
        )
        yield f"the sum of q differs from Q by {largest_difference:.2g} f P at most"
    if not discrepancy.unsymmetric:
        moment = np.trapezoid(x * discrepancy.result_tractions[PRESSURE], x, axis=1)[is_loaded]
        largest_eccentricity = (
            float(np.max(np.abs(moment / sum_of_pressure))) / discrepancy.half_width
        )
        yield f"the centre of p is {_rounded(largest_eccentricity):.2g} a_ref from x = 0 at most"


def _range(values: Array) -> str:
    """The least and the largest value; one where they are the same.

    >>> _range(np.array([3, 3])), _range(np.array([1.0, 1.25]))
    ('3', '1 to 1.25')
    """
    least_value, largest_value = (f"{value:.4g}" for value in (values.min(), values.max()))
    return least_value if least_value == largest_value else f"{least_value} to {largest_value}"


def _rounded(value: float) -> float:
    """0 in place of round-off."""
    return 0.0 if abs(value) < _ROUND_OFF else value


def _resolution(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on how finely a result is resolved: points in contact and in slip, spacing, scatter.
    `discrepancy` holds the tractions of result and reference.
    """
    comparison = discrepancy.comparison
    is_in_contact = discrepancy.in_contact(discrepancy.reference_tractions)
    points_in_contact = is_in_contact[discrepancy.loaded].sum(axis=1)
    if len(points_in_contact):
        yield f"{_range(points_in_contact)} points in contact at an instant"
    yield f"{discrepancy.elements:.3g} spacings over a_ref"
    if discrepancy.sheared and comparison.scene.friction.coefficient:
        points_in_slip = np.isin(comparison.result_cycle.state, (SLIP_FORWARD, SLIP_REVERSE)).sum(
            axis=1
        )
        yield f"{_range(points_in_slip)} points in slip"
    residuals = discrepancy.residuals(discrepancy.reference_tractions)
    scatter = [_rounded(residual.noise**0.5) for residual in residuals]
    scatter_in_words = (
        f"p changes from point to point by {scatter[PRESSURE]:.1g} of p_ref beside theory"
    )
    if discrepancy.sheared:
        scatter_in_words += f", q by {scatter[SHEAR]:.1g} of f p_ref"
    yield scatter_in_words


def _laws(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on the laws of contact: the largest violation of each, its limit, and whether scatter
    makes as much. `discrepancy` holds the tractions of result and reference.
    """
    names = {"cone": "|q| beyond f p, over f p_max", "tension": "tension over p_max"}
    residuals = discrepancy.residuals(discrepancy.reference_tractions)
    scatter = float(sum(residual.noise for residual in residuals if residual.is_noise)) ** 0.5
    for check in discrepancy.comparison.result_certificates:
        law_in_words = (
            f"{names.get(check.name, check.name)} {check.value:.2g} (limit {check.limit:.1g})"
        )
        if check.holds:
            yield f"{law_in_words}: holds"
        elif check.value <= _BY_SCATTER * scatter:
            yield f"{law_in_words}: no more than scatter makes"
        else:
            yield f"{law_in_words}: violated"


def _shape(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on the shape of the tractions beside the reference's: peak and width of the pressure,
    size of the shear. `discrepancy` holds the tractions of result and reference.
    """
    result_tractions = discrepancy.result_tractions
    expected_tractions = discrepancy.reference_tractions
    ratio_of_peaks = result_tractions[PRESSURE].max() / expected_tractions[PRESSURE].max()
    yield f"peak of p {ratio_of_peaks:.4g} times the reference's"
    widths = [
        _width(discrepancy, tractions[PRESSURE])
        for tractions in (result_tractions, expected_tractions)
    ]
    if min(widths) > 0:
        yield f"width by second moments {widths[0] / widths[1]:.4g} times"
    largest_shear = float(np.abs(expected_tractions[SHEAR]).max())
    if discrepancy.sheared and largest_shear:
        weight = discrepancy.weight
        product = float(np.sum(weight * result_tractions[SHEAR] * expected_tractions[SHEAR]))
        square_of_reference = float(np.sum(weight * expected_tractions[SHEAR] ** 2))
        yield minus(
            f"q {product / square_of_reference:.3g} times that of the reference, by least squares"
        )


def _width(discrepancy: Discrepancy, pressure: Array) -> float:
    """Root of the second moment of the pressure about its centre, over all instants [length]."""
    weight = discrepancy.weight * np.maximum(pressure, 0.0)
    total = float(weight.sum())
    if not total:
        return 0.0
    centre = float(np.sum(weight * discrepancy.x)) / total
    return float(np.sqrt(np.sum(weight * (discrepancy.x - centre) ** 2) / total))
