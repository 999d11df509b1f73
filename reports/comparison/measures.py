"""The functions that measure: each takes a `Pair` and gives one `Measured`, for one row of the
table in metrics.py.

Every one is a pure function of two last cycles on the same points and instants, dimensionless:
result − reference over a scale, signed wherever a sign has a meaning.

# notation: ref the reference, E the value of a metric, u its uncertainty
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.comparison.cycles import Cycle
from reports.comparison.pairs import Mask, Pair, name_of
from reports.comparison.work_of_loads import bulk_work, loop_work, on_straight_steps
from reports.python_numbers import PythonNumbers
from reports.units import minus
from scenes import OPEN, ContactSolution
from scenes.array_types import Array
from scenes.solution import range_of_slip

# Differences of size that are rounding: engines repeat themselves to 1e-11.
_ALIKE = 1e-9
# Below this, in A f^2 P_ref^2, a dissipation of the reference is the rounding of a sum whose truth
# is 0.
_NO_DISSIPATION = 1e-12
# Beside its scale, an amount of the reference of this share is nothing.
_NOTHING = 1e-12
# Share of theory's own value by which its value on the result's points may miss it: above, these
# points say nothing of the value.
_UNRESOLVED = 0.1
# Of the same share: below, both are the same to the digits of a table.
_SAME_DIGITS = 1e-6
# Of the finite elements, over their largest slip: their compliances are factorised.
_ROUND_OFF_OF_SLIP = 1e-11
# Over a_ref: stick edges this close to the contact edges are those.
_SAME_EDGE = 1e-9

_NOT_IN_CONTACT = "no instant has points in contact in both"
_NO_SLIP_RESOLVED = (
    "no node of the finite elements slips by more than round-off while it is in contact: what"
    " slips is narrower than an element; make edge_element_size smaller"
)
_NO_LOOP = "the path is not periodic: no loop"
_NO_DATUM = "no datum: c_t of these bodies is not known"
_WITH_COMPLIANCES = "with c_t, c_n of these bodies"


@dataclass(frozen=True, eq=False, kw_only=True)
class Measured(PythonNumbers):
    """What the function of a metric measures.

    Attributes
    ----------
    value
        of the last cycle, the worst where there is one at every instant; None where there is
        nothing to compare; not finite where the data is not
    time
        instant of the worst value; None for a figure of the whole cycle
    series
        (k,) values at the instants of the last cycle (NaN: nothing to compare), or None
    note
        what a reader must not miss
    elements
        value in local element sizes of the result, where it states one
    absolute
        whether the value is in the row's absolute unit, the reference's own figure being 0
    place
        where on the surface the worst value is, x/a_ref; None for what has no place
    uncertainty
        how far the error budget, else the engines' own statement, leaves the value open, in its
        unit; None where nobody states it
    amounts
        (reference, result) of a row with a quantity, in units of the scene; None for the others
    stated
        uncertainty that the solution states of either amount, in its unit: 0 exact, NaN no
        estimate, None from a solution that states nothing
    denominator
        what the difference of the two amounts is over, in their unit
    """

    value: float | None = None
    time: float | None = None
    series: Array | None = None
    note: str = ""
    elements: float | None = None
    absolute: bool = False
    place: float | None = None
    uncertainty: float | None = None
    amounts: tuple[float, float] | None = None
    stated: tuple[float | None, float | None] = (None, None)
    denominator: float | None = None

    @property
    def stated_by_result(self) -> float | None:
        """Uncertainty that the result states of its amount, in the unit of the value; None where it
        states none.

        >>> measured = Measured(amounts=(4.0, 3.6), stated=(0.0, 0.2), denominator=4.0)
        >>> measured.stated_by_result, measured.stated_by_reference
        (0.05, 0.0)
        """
        return self._in_its_unit(self.stated[1])

    @property
    def stated_by_reference(self) -> float | None:
        """That of the reference."""
        return self._in_its_unit(self.stated[0])

    @property
    def is_on_points_of_result(self) -> bool:
        """Whether `value` is not the difference of the two `amounts` (reference, result) over
        `denominator`.

        It is then taken on the points and instants of the result, where the reference has another
        value than its own.

        >>> Measured(value=0.0, amounts=(4.0, 3.9), denominator=3.9).is_on_points_of_result
        True
        """
        if self.value is None or self.amounts is None or self.denominator is None:
            return False
        reference_amount, result_amount = self.amounts
        difference = self.value * self.denominator
        mismatch = abs(result_amount - reference_amount - difference)
        return mismatch > _SAME_DIGITS * max(abs(reference_amount), abs(result_amount))

    def _in_its_unit(self, uncertainty: float | None) -> float | None:
        if uncertainty is None or not math.isfinite(uncertainty) or self.denominator is None:
            return None
        return uncertainty / abs(self.denominator)


# ------------------------------------------------------------------------- norms, shares, the worst


def norm(x: Array, values: Array) -> Array:
    """L2 norm over x, sqrt(int values^2 dx) by the trapezoidal rule: (..., n) -> (...)."""
    return np.sqrt(np.trapezoid(np.square(values), x, axis=-1))


def over(numerator: Array, denominator: Array) -> Array:
    """Quotient; 0/0 is NaN ("nothing to compare"), anything else over 0 is infinite."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.asarray(numerator / denominator, dtype=float)


def shares(positions: Array) -> Array:
    """Weights of the trapezoidal rule on the points or instants `positions`, (n,) -> (n,). Where
    all of `positions` are equal each weight is 1.

    >>> shares(np.array([0.0, 1.0, 3.0])).tolist(), shares(np.array([2.0])).tolist()
    ([0.5, 1.5, 1.0], [1.0])
    """
    if positions[-1] == positions[0]:
        return np.ones(len(positions))
    steps = np.diff(positions)
    steps_after = np.concatenate([steps, [0.0]])
    steps_before = np.concatenate([[0.0], steps])
    return np.asarray(steps_before + steps_after) / 2


def _first_largest(size: Array) -> int:
    """The first index of what is largest but for rounding.

    A cycle that is its own mirror image has each difference twice, with both signs: which of them
    is larger is chance.
    """
    return int(np.argmax(size >= (1 - _ALIKE) * size.max()))


def _worst(series: Array, applies: Mask, places: Array) -> tuple[float | None, float | None]:
    """The value of largest size in a series, and its place; the first where several are as large. A
    NaN counts as largest; (None, None) where no value applies.

    Parameters
    ----------
    series
        (k,) values
    applies
        (k,) which of them are looked at
    places
        (k,) times or places of the values

    Examples
    --------
    >>> _worst(np.array([1.0, -3.0, 9.0]), np.array([True, True, False]), np.array([0.0, 0.5, 1.0]))
    (-3.0, 0.5)
    """
    if not applies.any():
        return None, None
    sizes = np.where(np.isnan(series), np.inf, np.abs(series))
    worst_index = _first_largest(np.where(applies, sizes, -1.0))
    return float(series[worst_index]), float(places[worst_index])


def _at_worst(
    pair: Pair, series: Array, applies: Mask | None = None, **of_measured: Any
) -> Measured:
    """`series` (k,) at the worst of the instants that are judged, or of those that apply."""
    value, time = _worst(
        series, pair.is_judged if applies is None else applies, pair.result_cycle.time
    )
    return Measured(value=value, time=time, series=series, **of_measured)


def _nothing_to_compare(reason: str) -> Measured:
    """No value, with the reason in words."""
    return Measured(value=None, note=reason)


# -------------------------------------------------------------------------------- absolute values


def _of_amounts(
    reference_amount: float, result_amount: float, scale: float, **further_fields: Any
) -> Measured:
    """A metric of two amounts of the same quantity: (result - reference)/reference. Where the
    reference's amount is nothing (below 1e-12 of `scale`) the difference is over `scale` instead,
    and called absolute.

    Parameters
    ----------
    reference_amount
        amount of the reference
    result_amount
        amount of the result
    scale
        what counts as large of this quantity
    further_fields
        further fields of the metric, such as its times
    """
    is_absolute = abs(reference_amount) <= _NOTHING * scale
    denominator = scale if is_absolute else reference_amount
    return Measured(
        value=(result_amount - reference_amount) / denominator,
        absolute=is_absolute,
        amounts=(reference_amount, result_amount),
        denominator=denominator,
        **further_fields,
    )


def _beside_extremum(
    extremum: float,
    value_on_points: float,
    value_of_result: float,
    scale: float,
    *,
    is_external: bool,
    note: str = "",
) -> Measured:
    """Compare an extreme value, say the largest pressure, of result and reference: (result −
    reference)/reference.

    Parameters
    ----------
    extremum, value_on_points
        extreme value of the reference: its own, and as found on the points and instants of the
        result
    value_of_result
        the result's extreme value
    scale
        what the difference is divided by where the reference's own is 0
    is_external
        whether the result has points and instants of its own choice. Then the difference is that
        from `value_on_points`, so that what lies between the points drops out, and a note says so.
        Where `value_on_points` misses the reference's own by too much there is no value
    """
    amounts = (extremum, value_of_result)
    if math.isinf(extremum) and math.isfinite(value_of_result):
        return Measured(value=None, note="infinite in the reference", amounts=amounts)
    if not is_external:
        return _of_amounts(extremum, value_of_result, scale, note=note)
    size = abs(extremum) if abs(extremum) > _NOTHING * scale else scale
    share_missed = abs(value_on_points - extremum) / size
    if share_missed > _UNRESOLVED:
        reason_for_none = (
            "the result's points and instants are too few: on them the reference has"
            f" {value_on_points:.4g}"
            f" in place of {extremum:.4g}"
        )
        return Measured(value=None, note=reason_for_none, amounts=amounts)
    if share_missed > _SAME_DIGITS:
        note = (
            "the difference is that on the result's points and instants, where the reference has"
            f" {value_on_points:.5g}"
        )
    return replace(_of_amounts(value_on_points, value_of_result, scale, note=note), amounts=amounts)


def _beside_theory(
    pair: Pair, name: str, value_on_points: float, value_of_result: float, scale: float
) -> Measured:
    """The metric of a quantity's largest value, (result - reference)/reference.

    Half-plane theory knows its largest value (`name` in `pair.largest`) wherever it lies. Of
    another reference it is the largest on the points and instants that both have.

    Parameters
    ----------
    pair
        last cycles of reference and result
    value_on_points, value_of_result
        largest value of the reference on those points, and of the result
    scale
        what the difference is over where the reference's value is 0
    """
    extremum = value_on_points
    note = ""
    if pair.largest is not None:
        extremum = getattr(pair.largest, name)
        note = pair.largest.sampled
    is_external = pair.has_external_result
    return _beside_extremum(
        extremum, value_on_points, value_of_result, scale, is_external=is_external, note=note
    )


def _with_stated(pair: Pair, measurement: Measured, name: str, error: str = "") -> Measured:
    """A measured metric together with the uncertainties that reference and result themselves state
    of the two amounts that it compares.

    Parameters
    ----------
    pair
        last cycles of reference and result
    name
        key of the quantity among the uncertainties that finite elements state
    error
        key of the quantity among the relative errors that half-plane theory states; "" of what is
        exact there
    """
    if measurement.amounts is None:
        return measurement
    reference_value, result_value = measurement.amounts
    stated_uncertainties = (
        _uncertainty_stated(pair.plain_reference, reference_value, name, error),
        _uncertainty_stated(pair.result, result_value, name, error),
    )
    return replace(measurement, stated=stated_uncertainties)


def _uncertainty_stated(
    solution: ContactSolution, amount: float, name: str, error: str
) -> float | None:
    """Uncertainty that a solution itself states of an amount, in the amount's unit. NaN: it has no
    estimate; None: its engine states nothing.

    Parameters
    ----------
    amount
        value of the solution, such as its largest pressure
    name
        key of the amount among the uncertainties of finite elements
    error
        key of the amount among the relative errors of half-plane theory; "" where theory is exact
    """
    if solution.engine == "semi_analytic":
        return solution.record.errors.get(error, 0.0) * abs(amount)
    if solution.engine != "halfplane_fe":
        return None
    if name == "dissipation":
        return solution.dissipation_uncertainty
    return solution.uncertainties.get(name, math.nan)


def _place_of_largest(pair: Pair, values: Array) -> float:
    """x/a_ref of the largest of (n,)."""
    return float(pair.result_cycle.x[np.argmax(values)]) / pair.scales.half_width


def largest_pressure(pair: Pair) -> Measured:
    """Largest p of the cycle."""
    reference_value = float(pair.reference_cycle.pressure.max())
    result_value = float(pair.result_cycle.pressure.max())
    beside_theory = _beside_theory(
        pair, "pressure", reference_value, result_value, pair.scales.pressure
    )
    return _with_stated(pair, beside_theory, "largest_pressure", "pressure")


def largest_half_width(pair: Pair) -> Measured:
    """Largest half distance of the contact edges in the cycle."""
    reference_value = _largest_half_distance(pair.reference_cycle)
    result_value = _largest_half_distance(pair.result_cycle)
    beside_theory = _beside_theory(
        pair, "half_width", reference_value, result_value, pair.scales.half_width
    )
    return _with_stated(pair, beside_theory, "largest_half_width")


def _largest_half_distance(cycle: Cycle) -> float:
    return float(np.nanmax(np.diff(cycle.contact_edges, axis=1), initial=0.0)) / 2


def permanent_stick(pair: Pair) -> Measured:
    """Half-width of what sticks through the whole cycle."""
    length = _length_of_stick_zone(pair, _permanent_half_width)
    return _with_stated(pair, length, "permanent_stick_half_width")


def stick_eccentricity(pair: Pair) -> Measured:
    """Middle of what sticks through the whole cycle."""
    distance = _length_of_stick_zone(pair, _middle_of_stick)
    # Half the sum of two edges is as uncertain as half their distance.
    return _with_stated(pair, distance, "permanent_stick_half_width")


def _permanent_half_width(solution: ContactSolution) -> float:
    return solution.permanent_stick_half_width


def _middle_of_stick(solution: ContactSolution) -> float:
    edges = solution.permanent_stick_edges
    return math.nan if edges is None else float(np.mean(edges))


def _length_of_stick_zone(pair: Pair, length_of: Callable[[ContactSolution], float]) -> Measured:
    """A length of the zone that sticks through the whole cycle, result − reference over a_ref.
    `length_of` takes it from a solution; NaN means that there is no such zone. `pair` holds the
    last cycles of reference and result.
    """
    reference_value = float(length_of(pair.reference))
    result_value = float(length_of(pair.result))
    amounts = (float(length_of(pair.plain_reference)), result_value)
    if math.isnan(reference_value) and math.isnan(result_value):
        engines = f"{name_of(pair.reference.engine)} and {name_of(pair.result.engine)}"
        return _nothing_to_compare(f"none in {engines}")
    if math.isnan(reference_value):
        return Measured(note=f"none in {name_of(pair.reference.engine)}", amounts=amounts)
    if math.isnan(result_value):
        return Measured(note=f"none in {name_of(pair.result.engine)}", amounts=amounts)
    return Measured(
        value=(result_value - reference_value) / pair.scales.half_width,
        amounts=amounts,
        denominator=pair.scales.half_width,
    )


def largest_slip(pair: Pair) -> Measured:
    """Largest range of the slip s that any point has while in contact, result beside reference,
    each on its own points.

    No value where the finite elements slip by no more than round-off and theory does slip. `pair`
    holds the last cycles of reference and result.
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    if not pair.result.scene.friction.coefficient:
        return _nothing_to_compare("nothing resists slip")
    touches_in_result = result_cycle.state != OPEN
    touches_in_reference = reference_cycle.state != OPEN
    if not touches_in_result.any():
        return _nothing_to_compare(_NOT_IN_CONTACT)
    range_in_result = range_of_slip(result_cycle.slip, touches_in_result)
    reference_value = float(range_of_slip(reference_cycle.slip, touches_in_reference).max())
    result_value = float(range_in_result.max())
    measurement = _beside_theory(pair, "slip", reference_value, result_value, pair.scales.slip)
    measurement = _with_stated(pair, measurement, "largest_slip", "slip")
    if pair.result.engine == "halfplane_fe" and measurement.amounts is not None:
        # Where all slip is round-off, slip is narrower than an element: no value, and the cure.
        round_off = _ROUND_OFF_OF_SLIP * float(np.max(np.abs(result_cycle.slip)))
        if result_value <= round_off < measurement.amounts[0]:
            return replace(measurement, value=None, note=_NO_SLIP_RESOLVED)
    return replace(measurement, place=_place_of_largest(pair, range_in_result))


def largest_slip_common(pair: Pair) -> Measured:
    """Largest range of the slip s, over the points and instants in contact in both result and
    reference; the result's relative difference. `pair` holds the last cycles of reference and
    result.
    """
    is_touching = _in_contact_in_both(pair)
    if not is_touching.any():
        return _nothing_to_compare(_NOT_IN_CONTACT)
    range_in_result = range_of_slip(pair.result_cycle.slip, is_touching)
    reference_value = float(range_of_slip(pair.reference_cycle.slip, is_touching).max())
    result_value = float(range_in_result.max())
    return _of_amounts(
        reference_value,
        result_value,
        pair.scales.slip,
        place=_place_of_largest(pair, range_in_result),
    )


def _in_contact_in_both(pair: Pair) -> Mask:
    """(k, n) points and instants in contact in both."""
    return np.asarray((pair.reference_cycle.state != OPEN) & (pair.result_cycle.state != OPEN))


def dissipation(pair: Pair) -> Measured:
    """Difference in the friction work W of the last cycle, (result − reference)/reference. Absolute
    where the reference dissipates nothing.

    Of an external result the difference is that from the reference's W by the rule and points of
    the result, `pair.reference`; the table shows the reference's own W, `pair.plain_reference`.
    `pair` holds the last cycles of reference and result.
    """
    measurement = _beside_extremum(
        pair.plain_reference.dissipation,
        pair.reference.dissipation,
        pair.result.dissipation,
        pair.scales.dissipation,
        is_external=pair.plain_reference is not pair.reference,
    )
    measurement = _with_stated(pair, measurement, "dissipation", "dissipation")
    if measurement.absolute:
        note = "the reference dissipates nothing, so the value is absolute"
        return replace(measurement, note=note)
    return measurement


def largest_dissipation_density(pair: Pair) -> Measured:
    """Largest friction work per area w(x) of the last cycle: (result - reference)/reference, with
    the place of the result's largest value. `pair` holds the last cycles of reference and result.
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    value_on_points = float(reference_cycle.dissipation_density.max())
    largest_value = float(result_cycle.dissipation_density.max())
    measurement = _beside_theory(
        pair, "dissipation_density", value_on_points, largest_value, pair.scales.density
    )
    measurement = _with_stated(
        pair, measurement, "largest_dissipation_density", "dissipation_density"
    )
    return replace(measurement, place=_place_of_largest(pair, result_cycle.dissipation_density))


def edge_tension(pair: Pair) -> Measured:
    """Difference in the largest tensile stress along a face at an edge of contact, (result −
    reference)/reference.

    Its uncertainty is the sum of those that both state. No value without friction, or where either
    does not know that stress. `pair` holds the last cycles of reference and result.
    """
    if not pair.result.scene.friction.coefficient:
        return _nothing_to_compare("frictionless: nothing stretches the faces")
    tension_of_reference = _largest_tension(pair.plain_reference, pair)
    tension_of_result = _largest_tension(pair.result, pair)
    if tension_of_reference is None or tension_of_result is None:
        return _one_tension(pair, tension_of_reference, tension_of_result)

    reference_value, reference_uncertainty = tension_of_reference
    result_value, result_uncertainty = tension_of_result
    measurement = _of_amounts(reference_value, result_value, pair.scales.shear)
    scale = pair.scales.shear if measurement.absolute else abs(reference_value)
    relative_uncertainty = (reference_uncertainty + result_uncertainty) / scale
    stated_uncertainties = (reference_uncertainty, result_uncertainty)
    return replace(measurement, uncertainty=relative_uncertainty, stated=stated_uncertainties)


def _one_tension(
    pair: Pair, of_reference: tuple[float, float] | None, of_result: tuple[float, float] | None
) -> Measured:
    """The largest tension at an edge of contact and its uncertainty [stress] where the reference or
    the result, or neither, knows it: nothing to compare, with the value that there is.
    """
    unknown = (math.nan, math.nan)
    reference_value, reference_uncertainty = of_reference or unknown
    result_value, result_uncertainty = of_result or unknown
    engines_without_value = [
        name_of(solution.engine)
        for solution, tension in ((pair.reference, of_reference), (pair.result, of_result))
        if tension is None
    ]
    return replace(
        _nothing_to_compare(f"not known of {' and '.join(engines_without_value)}"),
        amounts=(reference_value, result_value),
        stated=(reference_uncertainty, result_uncertainty),
    )


def _largest_tension(solution: ContactSolution, pair: Pair) -> tuple[float, float] | None:
    """The largest tension at an edge of contact and its uncertainty [stress]."""
    import halfplane_fe

    if solution.engine == "semi_analytic" and pair.largest is not None:
        return pair.largest.edge_tension, pair.largest.edge_tension_uncertainty
    if solution.engine != "halfplane_fe":
        return None
    largest_tension = halfplane_fe.largest_edge_tension(solution)
    return None if largest_tension is None else (largest_tension.value, largest_tension.uncertainty)


# ------------------------------------------------------------------------------- pressure and shear


def peak_pressure(pair: Pair) -> Measured:
    """Largest p of each instant.

    Both maxima over the same points: where these lie beside the true peak cancels. A reference at
    its own peak would make every result look too low by up to (h/a)^2/8.
    """
    reference_value = pair.reference_cycle.pressure.max(axis=1)
    result_value = pair.result_cycle.pressure.max(axis=1)
    return _at_worst(pair, over(result_value - reference_value, reference_value))


def pressure(pair: Pair) -> Measured:
    """L2 norm of the difference of the pressure over that of the pressure."""
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    x = result_cycle.x
    difference = norm(x, result_cycle.pressure - reference_cycle.pressure)
    series = over(difference, norm(x, reference_cycle.pressure))
    return _at_worst(pair, series, stated=_stated_norms(pair, "pressure"), denominator=1.0)


def shear(pair: Pair) -> Measured:
    """L2 norm of the difference of the shear over f times that of the pressure."""
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    x = result_cycle.x
    difference = norm(x, result_cycle.shear - reference_cycle.shear)
    series = over(difference, pair.scales.friction * norm(x, reference_cycle.pressure))
    return _at_worst(pair, series, stated=_stated_norms(pair, "shear"), denominator=1.0)


def _stated_norms(pair: Pair, name: str) -> tuple[float | None, float | None]:
    """Uncertainty that the reference and the result state of p or q in L2, as a share."""
    return (
        _uncertainty_stated(pair.plain_reference, 1.0, name, name),
        _uncertainty_stated(pair.result, 1.0, name, name),
    )


def normal_resultant(pair: Pair) -> Measured:
    """P that the tractions carry."""
    return _resultant(pair, _normal_resultant, "normal_load")


def tangential_resultant(pair: Pair) -> Measured:
    """Q that the tractions carry."""
    return _resultant(pair, _tangential_resultant, "tangential_load")


def _normal_resultant(cycle: Cycle, weights: Array, normals: Array) -> Array:
    """Normal load P that the tractions of a cycle carry at each instant, (k,) [force / thickness].

    Parameters
    ----------
    weights
        (n,) share of the surface of each point [length]
    normals
        (2, n) out of the lower body, p acting along it and q across it
    """
    normal_x, normal_y = normals
    resultant = np.asarray(cycle.pressure @ (weights * normal_y))
    # Zero times no shear, which a pressure alone has, is nothing of P.
    if normal_x.any():
        resultant = resultant + cycle.shear @ (weights * normal_x)
    return resultant


def _tangential_resultant(cycle: Cycle, weights: Array, normals: Array) -> Array:
    """Q that the tractions of `cycle` carry, as `_normal_resultant`."""
    along_face, across_face = normals
    return np.asarray(
        cycle.shear @ (weights * across_face) - cycle.pressure @ (weights * along_face)
    )


def _resultant(
    pair: Pair, resultant_of: Callable[[Cycle, Array, Array], Array], name_of_load: str
) -> Measured:
    """Difference of the load that the result's tractions carry from the load that the result
    states, over P, at the worst instant: a check of equilibrium.

    With the result's own weights of points nothing of the reference enters. Otherwise tractions are
    integrated by the trapezoidal rule, and the rule's error, found from the reference, is
    subtracted.

    Parameters
    ----------
    pair
        last cycles of reference and result
    resultant_of
        integrates tractions, (cycle, weights, normals) -> (k,)
    name_of_load
        name of the stated load in a cycle
    """
    x = pair.result_cycle.x
    normals_of_flat = np.array([np.zeros_like(x), np.ones_like(x)])
    weights = getattr(pair.result, "weights", None)
    normals = getattr(pair.result, "normals", None)
    note = ""
    weights_of_points = shares(x) if weights is None else weights
    normals_of_points = normals_of_flat if normals is None else normals
    resultant = resultant_of(pair.result_cycle, weights_of_points, normals_of_points)
    excess = resultant - getattr(pair.result_cycle, name_of_load)
    if weights is None:
        resultant_of_reference = resultant_of(pair.reference_cycle, shares(x), normals_of_flat)
        error_of_rule = resultant_of_reference - getattr(pair.reference_cycle, name_of_load)
        excess = excess - error_of_rule
        note = (
            "the result states no weights, so by the trapezoidal rule, minus its error for the"
            " reference"
        )
    return _at_worst(pair, over(excess, pair.result_cycle.normal_load), note=note)


# -------------------------------------------------------------------------- contact, stick and slip


def contact_edge(pair: Pair) -> Measured:
    """Outward shift of the worse contact edge."""
    shift = _shift_of_worse_edge(
        pair.reference_cycle.contact_edges, pair.result_cycle.contact_edges
    )
    measurement = _at_worst(pair, shift / pair.scales.half_width)
    return replace(measurement, elements=_in_elements(pair, measurement.value))


def stick_edge(pair: Pair) -> Measured:
    """Outward shift of the worse edge of the stick zone over a_ref, at instants at which result and
    reference both have one.

    The note counts the instants at which the two differ in full stick, partial slip or full slip.
    `pair` holds the last cycles of reference and result.
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    length = pair.scales.half_width
    status_of_reference = _stick_status(reference_cycle, length)
    status_of_result = _stick_status(result_cycle, length)
    shift = _shift_of_worse_edge(reference_cycle.stick_edges, result_cycle.stick_edges)
    is_compared = pair.is_judged & _with_stick_edges(status_of_reference, status_of_result)
    measurement = _at_worst(pair, shift / length, is_compared)

    n_differing = int((status_of_reference != status_of_result)[pair.is_judged].sum())
    note = ""
    if n_differing:
        note = (
            f"{n_differing} of {int(pair.is_judged.sum())} instants differ in full stick, partial"
            " slip or full slip"
        )
    if measurement.value is None and n_differing:
        reason_for_none = f"no instant has a stick edge in both: {note}"
        return replace(measurement, value=math.nan, note=reason_for_none)
    return replace(measurement, note=note, elements=_in_elements(pair, measurement.value))


def _shift_of_worse_edge(of_reference: Array, of_result: Array) -> Array:
    """Outward shift of the worse of two edges, (k,) from (k, 2); NaN where either lacks the edge.

    >>> _shift_of_worse_edge(np.array([[-1.0, 1.0]]), np.array([[-1.02, 1.01]])).round(12).tolist()
    [0.02]
    """
    outward = (of_result - of_reference) * np.array([-1.0, 1.0])
    worse_side = np.argmax(np.abs(outward), axis=1)
    return np.asarray(outward[np.arange(len(outward)), worse_side])


def _in_elements(pair: Pair, value: float | None) -> float | None:
    """An edge's shift in local element sizes of the result, which it states as
    `settings["element_size"]` [length].
    """
    size = pair.result.settings.get("element_size")
    if not size or value is None:
        return None
    return value * pair.scales.half_width / float(size)


_FULL_SLIP = 0
_PARTIAL_SLIP = 1
_FULL_STICK = 2
_OUT_OF_CONTACT = -1


def _stick_status(cycle: Cycle, length: float) -> NDArray[np.int8]:
    """Status of the whole contact at each instant, (k,): full slip, partial slip, full stick, or
    out of contact.

    Full stick: the stick edges are the contact edges (to 1e-9 `length`). Full slip: they are NaN.
    """
    distance = np.max(np.abs(cycle.stick_edges - cycle.contact_edges), axis=1)
    status = np.where(distance <= _SAME_EDGE * length, _FULL_STICK, _PARTIAL_SLIP)
    status[np.isnan(distance)] = _FULL_SLIP
    carries = cycle.pressure.max(axis=1) > 0
    return np.where(carries, status, _OUT_OF_CONTACT).astype(np.int8)


def _with_stick_edges(
    status_of_reference: NDArray[np.int8], status_of_result: NDArray[np.int8]
) -> Mask:
    """Instants at which the edges of two stick zones can be compared, (k,), from the status of the
    whole contact in reference and result: -1 open, 0 full slip, 1 partial slip, 2 full stick.

    Both must have edges. Left out is an instant by which one of them changes to or from full stick
    earlier than the other: the edge jumps there, which is an error of time and not of place.

    >>> _with_stick_edges(
    ...     np.array([1, 1, 2, 2, 1, 1], dtype=np.int8), np.array([1, 1, 1, 2, 1, 2], dtype=np.int8)
    ... ).tolist()
    [True, True, False, True, True, True]
    """
    both_have_edges = (status_of_reference != _FULL_SLIP) & (status_of_result != _FULL_SLIP)
    is_one_step_late = (
        (status_of_reference != status_of_result)
        & _is_that_of_a_neighbour(status_of_reference, status_of_result)
        & _is_that_of_a_neighbour(status_of_result, status_of_reference)
    )
    return np.asarray(both_have_edges & ~is_one_step_late)


def _is_that_of_a_neighbour(status: NDArray[np.int8], neighbours: NDArray[np.int8]) -> Mask:
    """(k,) whether `status` is that of `neighbours` one instant before or after."""
    return np.asarray((status == np.roll(neighbours, 1)) | (status == np.roll(neighbours, -1)))


def state(pair: Pair) -> Measured:
    """Share of the length in contact on which the states (stick, slip, open) of result and
    reference differ, at each instant; the value is the mean over time of the instants in contact.
    `pair` holds the last cycles of reference and result.
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    lengths = np.gradient(result_cycle.x)
    is_touching = (reference_cycle.state != OPEN) | (result_cycle.state != OPEN)
    differs = reference_cycle.state != result_cycle.state
    series = over((differs * lengths).sum(axis=1), (is_touching * lengths).sum(axis=1))
    time = result_cycle.time[pair.is_in_contact]
    if not len(time) or time[-1] == time[0]:
        return Measured(value=None, series=series)
    mean_share = np.trapezoid(series[pair.is_in_contact], time) / (time[-1] - time[0])
    return Measured(value=float(mean_share), series=series)


def slip(pair: Pair) -> Measured:
    """Root mean square of s − s_ref over the range of s_ref, at the worst instant; s is the slip of
    the points in contact in both.

    A point that is open is displaced, and nothing slips there. Absolute, over f p_ref a_ref/E*,
    where the range of s_ref is below 1e-12 of that. `pair` holds the last cycles of reference and
    result.
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    is_touching = _in_contact_in_both(pair)
    applies = pair.is_judged & is_touching.any(axis=1)
    if not applies.any():
        return _nothing_to_compare(_NOT_IN_CONTACT)
    range_of_reference = np.ptp(reference_cycle.slip[is_touching])
    is_absolute = bool(range_of_reference <= _NOTHING * pair.scales.slip)
    scale = pair.scales.slip if is_absolute else range_of_reference
    difference = np.where(is_touching, (result_cycle.slip - reference_cycle.slip) / scale, 0.0)
    length_in_contact = is_touching * shares(result_cycle.x)
    mean_square = over(
        (difference**2 * length_in_contact).sum(axis=1), length_in_contact.sum(axis=1)
    )
    return _at_worst(pair, np.sqrt(mean_square), applies, absolute=is_absolute)


def moment(pair: Pair) -> Measured:
    """M of each instant."""
    return _series_of_tilted(pair, "moment", pair.scales.moment)


def tilt(pair: Pair) -> Measured:
    """Tilt of each instant."""
    return _series_of_tilted(pair, "tilt", pair.scales.tilt)


def _series_of_tilted(pair: Pair, name: str, scale: float) -> Measured:
    """A series over time that not every solution states, result − reference."""
    reference_values = getattr(pair.reference_cycle, name)
    result_values = getattr(pair.result_cycle, name)
    if reference_values is None or result_values is None:
        return _nothing_to_compare("a solution states none")
    return _at_worst(pair, (result_values - reference_values) / scale)


# ---------------------------------------------------------------------------------- work and energy


def tangential_displacement(pair: Pair) -> Measured:
    """Difference of the tangential displacement U, over the range of U_ref in the cycle, at the
    worst instant.

    No value where the two count U from different places, or where the reference does not move
    sideways. `pair` holds the last cycles of reference and result.
    """
    if pair.lacks_common_datum:
        return _nothing_to_compare(_NO_DATUM)
    reference_values = pair.reference_cycle.tangential_displacement
    result_values = pair.result_cycle.tangential_displacement
    stroke = float(np.ptp(reference_values))
    least_stroke = _NOTHING * pair.scales.shift
    if stroke <= least_stroke:
        no_values = np.full_like(reference_values, np.nan)
        note = "the reference does not move sideways"
        return Measured(value=None, series=no_values, note=note)
    # A stroke that is NaN moves: it must not count as standing still and hide.
    series = np.full_like(reference_values, np.nan)
    if stroke > least_stroke:
        series = (result_values - reference_values) / stroke
    note = "" if pair.effects is None else _WITH_COMPLIANCES
    if not pair.is_judged.any():
        note = "the reference does not move sideways"
    return _at_worst(pair, series, note=note)


def displacement_amplitude(pair: Pair) -> Measured:
    """Half the range of U in the cycle."""
    return _amplitude(pair, "tangential_displacement", "U does not vary")


def approach_amplitude(pair: Pair) -> Measured:
    """Half the range of the normal approach in the cycle."""
    return _amplitude(pair, "normal_approach", "the approach does not vary")


def _amplitude(pair: Pair, name: str, reason_for_none: str) -> Measured:
    """Half the range of a displacement in the cycle, over that of the reference, − 1."""
    reference_value = float(np.ptp(getattr(pair.reference_cycle, name))) / 2
    result_value = float(np.ptp(getattr(pair.result_cycle, name))) / 2
    if not math.isfinite(reference_value + result_value):
        return _nothing_to_compare("a solution states none")
    if reference_value <= _NOTHING * pair.scales.shift:
        return _nothing_to_compare(reason_for_none)
    return _of_amounts(reference_value, result_value, pair.scales.shift, note=_WITH_COMPLIANCES)


def dissipation_without_steps(pair: Pair) -> Measured:
    """W of both on the straight lines between the instants: the error of the steps is taken out."""
    polygon = pair.polygon_reference or pair.reference
    straight = on_straight_steps(pair.result)
    return _of_amounts(polygon.dissipation, straight.dissipation, pair.scales.dissipation)


def dissipation_of_steps(pair: Pair) -> Measured:
    """What straight load increments do to the friction work W of half-plane theory: (W along the
    result's straight increments − W along the smooth path)/(W along the smooth path).

    Finite elements add work within an increment for the curve of the path. The former W is scaled
    by that share too. `pair` holds the last cycles of reference and result.
    """
    reference_on_steps = pair.polygon_reference or pair.reference
    work_on_steps = on_straight_steps(pair.result).dissipation
    factor_of_curve = pair.result.dissipation / work_on_steps if work_on_steps else 1.0
    return _of_amounts(
        pair.reference.dissipation,
        reference_on_steps.dissipation * factor_of_curve,
        pair.scales.dissipation,
    )


def hysteresis(pair: Pair) -> Measured:
    """Closed integral of Q dU."""
    if not pair.periodic:
        return _nothing_to_compare(_NO_LOOP)
    return _of_amounts(
        loop_work(pair.reference_cycle), loop_work(pair.result_cycle), pair.scales.dissipation
    )


def bulk_term(pair: Pair) -> Measured:
    """Work of the bulk stress per cycle, −(closed integral of m_q d(eps)): the result's minus the
    reference's, over the friction work W of the reference. m_q is the moment of the shear, eps the
    bulk strain. Where the reference does no friction work it is over A f^2 P_ref^2, A the
    compliance of both bodies, and marked `absolute`. `pair` holds the last cycles of both.
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    if not pair.periodic:
        return _nothing_to_compare(_NO_LOOP)
    for cycle, solution in ((reference_cycle, pair.reference), (result_cycle, pair.result)):
        if cycle.shear_moment is None:
            return _nothing_to_compare(f"{name_of(solution.engine)} states no moment of its shear")
    materials = pair.result.scene.material
    difference = bulk_work(result_cycle, materials) - bulk_work(reference_cycle, materials)
    work = pair.reference.dissipation
    scale_of_work = pair.scales.dissipation
    has_no_work = abs(work) <= _NO_DISSIPATION * scale_of_work
    denominator = scale_of_work if has_no_work else work
    return Measured(value=difference / denominator, absolute=has_no_work)


def drift(pair: Pair) -> Measured:
    """How far the friction work W still changes from cycle to cycle: the change in the last cycle
    over W, result − reference. The note states both changes. `pair` holds the last cycles of
    reference and result.
    """
    reference_value = pair.reference.dissipation_drift
    result_value = pair.result.dissipation_drift
    sentences = []
    for solution, change in ((pair.reference, reference_value), (pair.result, result_value)):
        if math.isnan(change):
            sentences.append(f"{name_of(solution.engine)}: not known")
        elif change:
            change_in_words = minus(f"{change:+.1e}")
            sentences.append(f"{name_of(solution.engine)}: {change_in_words} in its last cycle")
    note = "; ".join(sentences)
    if math.isnan(reference_value) or math.isnan(result_value):
        return _nothing_to_compare(note)
    return Measured(value=result_value - reference_value, note=note)


def dissipation_density(pair: Pair) -> Measured:
    """Friction work per area, w(x) − w_ref(x) over the largest w_ref, at the worst point.

    Absolute, over A f^2 P_ref^2/a_ref, where the reference does no friction work anywhere (a NaN
    counts as work). `pair` holds the last cycles of reference and result.
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    reference_values = reference_cycle.dissipation_density
    largest_reference = np.max(np.abs(reference_values))
    is_absolute = bool(largest_reference <= _NO_DISSIPATION * pair.scales.density)
    scale = pair.scales.density if is_absolute else largest_reference
    difference = (result_cycle.dissipation_density - reference_values) / scale
    value, x = _worst(difference, np.ones(len(difference), bool), result_cycle.x)
    place = None if x is None else x / pair.scales.half_width
    return Measured(value=value, absolute=is_absolute, place=place)


def energy_balance(pair: Pair) -> Measured:
    """From the record of the result, which alone knows what its bodies store."""
    balance = pair.result.record.certificates.get("energy_balance")
    if balance is None:
        return _nothing_to_compare("the result records none")
    series = np.asarray(balance, dtype=float)[pair.result.last_cycle]
    return _at_worst(pair, series, np.ones(len(series), bool))
