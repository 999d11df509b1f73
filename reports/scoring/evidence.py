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
_LARGEST_IMBALANCE = 0.01
# Of its unit: less is round-off.
_ROUND_OFF = 1e-10
# Standard deviations of the scatter, of which it makes as much at one of many points.
_DEVIATIONS_BY_SCATTER = 5.0


@dataclass(frozen=True)
class EvidenceStep:
    """One step of the evidence.

    Attributes
    ----------
    name
        title of the step
    words
        what was measured, in words
    """

    name: str
    words: str

    @property
    def sentence(self) -> str:
        """Title and what was measured."""
        return f"{self.name}: {self.words}"


def evidence_steps(comparison: Comparison) -> tuple[EvidenceStep, ...]:
    """What an external result shows about itself and beside the reference, in five steps, each with
    its title and a sentence: what was read, equilibrium, resolution, laws of contact, shape. Empty
    where neither result nor reference has a contact.
    """
    # tractions of result and reference at instants of the last cycle; None without a contact
    discrepancy = discrepancy_of(comparison)
    if discrepancy is None:
        return ()
    # title and words of each step
    return (
        EvidenceStep("What was read", _fields_in_words(comparison)),
        EvidenceStep("Equilibrium", "; ".join(_phrases_on_equilibrium(discrepancy))),
        EvidenceStep("Resolution", "; ".join(_phrases_on_resolution(discrepancy))),
        EvidenceStep("Laws", "; ".join(_phrases_on_laws(discrepancy))),
        EvidenceStep("Shape", "; ".join(_phrases_on_shape(discrepancy))),
    )


def _fields_in_words(comparison: Comparison) -> str:
    """In words: which fields an external result has, at how many points and instants of its last
    cycle, and from which x to which.
    """
    result_cycle = comparison.result_cycle
    fields_in_words = "pressure alone"
    if not np.isnan(result_cycle.shear).all():
        fields_in_words = "pressure and shear"
    if np.isfinite(result_cycle.slip).any():
        fields_in_words += ", slip"
    return (
        f"{fields_in_words} at {len(result_cycle.x)} points from x ="
        # minus: hyphen to minus sign
        f" {minus(f'{result_cycle.x[0]:.4g}')} to"
        f" {minus(f'{result_cycle.x[-1]:.4g}')} and {len(result_cycle.time)} instants of the"
        " last cycle"
    )


def _phrases_on_equilibrium(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on the integrals of the result's tractions over x: that of the pressure p beside P,
    and that of the shear q beside Q. A third one is on the centre of p, which a symmetric scene has
    at x = 0. They are of instants with a load; nothing without one. `discrepancy` holds tractions
    of result and reference.

    # notation: a_ref half-width of contact of the reference, f coefficient of friction, P normal
    #           load, Q tangential load
    """
    is_loaded = discrepancy.is_loaded
    if not is_loaded.any():
        return
    x = discrepancy.x
    pressure, shear = discrepancy.result_tractions[:, is_loaded]
    integral_of_pressure = np.trapezoid(pressure, x, axis=1)
    normal_load = discrepancy.normal_load[is_loaded]
    # integral of p over P or over that of the reference, whichever is nearer to 1
    resultant_ratio = discrepancy.resultant_ratio
    # least and largest value of the instants
    range_of_ratios = _range_in_words(integral_of_pressure / normal_load)
    sum_in_words = f"the sum of p is {resultant_ratio:.4g} P ({range_of_ratios} by instants)"
    # to 1 %
    if abs(resultant_ratio - 1) < _LARGEST_IMBALANCE:
        sum_in_words += ", so that no load, thickness or unit of it is wrong"
    yield sum_in_words
    friction_coefficient = discrepancy.comparison.scene.friction.coefficient
    if discrepancy.has_shear and friction_coefficient:
        integral_of_shear = np.trapezoid(shear, x, axis=1)
        loaded_instants = discrepancy.instants_of_cycle[is_loaded]
        tangential_load = discrepancy.comparison.reference_cycle.tangential_load[loaded_instants]
        differences_from_load = np.abs(integral_of_shear - tangential_load) / (
            friction_coefficient * normal_load
        )
        largest_difference = float(np.max(differences_from_load))
        yield f"the sum of q differs from Q by {largest_difference:.2g} f P at most"
    if not discrepancy.unsymmetric:
        moment = np.trapezoid(x * pressure, x, axis=1)
        eccentricities = np.abs(moment / integral_of_pressure)
        largest_eccentricity = _without_round_off(
            float(np.max(eccentricities)) / discrepancy.half_width
        )
        yield f"the centre of p is {largest_eccentricity:.2g} a_ref from x = 0 at most"


def _range_in_words(values: Array) -> str:
    """The least and the largest value; one where they are the same.

    >>> _range_in_words(np.array([3, 3])), _range_in_words(np.array([1.0, 1.25]))
    ('3', '1 to 1.25')
    """
    least_value, largest_value = (f"{value:.4g}" for value in (values.min(), values.max()))
    return least_value if least_value == largest_value else f"{least_value} to {largest_value}"


def _without_round_off(value: float) -> float:
    """A value; 0 in place of round-off."""
    return 0.0 if abs(value) < _ROUND_OFF else value


def _phrases_on_resolution(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on how finely a result is resolved: number of points in contact and in slip, spacing
    of the points, scatter of the tractions. `discrepancy` holds those of result and reference, at k
    instants and n points.

    # notation: a_ref half-width of contact of the reference, f coefficient of friction, p pressure,
    #           p_ref its scale, q shear
    """
    comparison = discrepancy.comparison
    # whether a point has pressure in the result or in the reference, (k, n)
    is_in_contact = discrepancy.mask_in_contact(discrepancy.reference_tractions)
    n_points_in_contact = is_in_contact[discrepancy.is_loaded].sum(axis=1)
    if len(n_points_in_contact):
        yield f"{_range_in_words(n_points_in_contact)} points in contact at an instant"
    yield f"{discrepancy.elements_per_half_width:.3g} spacings over a_ref"
    if discrepancy.has_shear and comparison.scene.friction.coefficient:
        is_in_slip = np.isin(comparison.result_cycle.state, (SLIP_FORWARD, SLIP_REVERSE))
        n_points_in_slip = is_in_slip.sum(axis=1)
        yield f"{_range_in_words(n_points_in_slip)} points in slip"
    # result minus reference, over p_ref and f p_ref
    residuals = discrepancy.residuals(discrepancy.reference_tractions)
    # root mean square of the noise from point to point, over p_ref and f p_ref
    scatter = [_without_round_off(residual.mean_square_of_noise**0.5) for residual in residuals]
    scatter_in_words = (
        f"p changes from point to point by {scatter[PRESSURE]:.1g} of p_ref beside theory"
    )
    if discrepancy.has_shear:
        scatter_in_words += f", q by {scatter[SHEAR]:.1g} of f p_ref"
    yield scatter_in_words


def _phrases_on_laws(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on the laws of contact and friction: the largest violation of each in the result, its
    limit, and whether scatter of the tractions makes as much.

    # notation: f coefficient of friction, p pressure, p_ref scale of pressure, q shear
    """
    # by name of the check; "cone": Coulomb's limit; p_max: the largest pressure
    words_of_law = {"cone": "|q| beyond f p, over f p_max", "tension": "tension over p_max"}
    residuals = discrepancy.residuals(discrepancy.reference_tractions)
    # of p/p_ref and q/(f p_ref) together, where the differences are noise alone
    scatter = (
        float(sum(residual.mean_square_of_noise for residual in residuals if residual.is_noise))
        ** 0.5
    )
    # checks of the laws: name, largest violation `value`, and limit
    for law_check in discrepancy.comparison.result_certificates:
        law_in_words = words_of_law.get(law_check.name, law_check.name)
        law_in_words += f" {law_check.value:.2g} (limit {law_check.limit:.1g})"
        if law_check.holds:
            yield f"{law_in_words}: holds"
        # five standard deviations of the scatter
        elif law_check.value <= _DEVIATIONS_BY_SCATTER * scatter:
            yield f"{law_in_words}: no more than scatter makes"
        else:
            yield f"{law_in_words}: violated"


def _phrases_on_shape(discrepancy: Discrepancy) -> Iterator[str]:
    """Phrases on the tractions of the result over the reference's: ratios of peak and width of the
    pressure p, and the factor between the shears q. `discrepancy` holds the tractions of both,
    (2, k, n), at k instants and n points.
    """
    result_tractions = discrepancy.result_tractions
    reference_tractions = discrepancy.reference_tractions
    ratio_of_peaks = result_tractions[PRESSURE].max() / reference_tractions[PRESSURE].max()
    yield f"peak of p {ratio_of_peaks:.4g} times the reference's"
    result_width = _width_by_second_moment(discrepancy, result_tractions[PRESSURE])
    reference_width = _width_by_second_moment(discrepancy, reference_tractions[PRESSURE])
    if result_width > 0 and reference_width > 0:
        yield f"width by second moments {result_width / reference_width:.4g} times"
    largest_shear = float(np.abs(reference_tractions[SHEAR]).max())
    if discrepancy.has_shear and largest_shear:
        # (k, n) weight of each instant and point in sums
        weight = discrepancy.weight
        product = float(np.sum(weight * result_tractions[SHEAR] * reference_tractions[SHEAR]))
        square_of_reference = float(np.sum(weight * reference_tractions[SHEAR] ** 2))
        yield minus(
            f"q {product / square_of_reference:.3g} times that of the reference, by least squares"
        )


def _width_by_second_moment(discrepancy: Discrepancy, pressure: Array) -> float:
    """Width of a pressure distribution (k, n) at k instants and n points: root of its second moment
    over its sum [length]; 0 without pressure. Moment and sum are over all instants together, about
    one centre for all of them. Negative pressure counts as 0.
    """
    # weight (k, n): of each instant and point in sums
    weighted_pressure = discrepancy.weight * np.maximum(pressure, 0.0)
    sum_of_pressure = float(weighted_pressure.sum())
    if not sum_of_pressure:
        return 0.0
    centre = float(np.sum(weighted_pressure * discrepancy.x)) / sum_of_pressure
    second_moment = np.sum(weighted_pressure * (discrepancy.x - centre) ** 2) / sum_of_pressure
    return float(np.sqrt(second_moment))
