"""The functions that measure: each takes a `Pair` and returns one `MetricValue`, for one row of the
table in metrics.py.

Each compares two last cycles, that of the reference and that of the result, on the same points and
instants. The value is dimensionless: result − reference over a scale, with a sign wherever a sign
has a meaning.

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
from reports.comparison.pairs import (
    Mask,
    Pair,
    engine_in_words,
    is_corrected,
    stated_uncertainty,
)
from reports.comparison.work_of_loads import bulk_work, loop_work, solution_on_straight_steps
from reports.units import PythonNumbers, minus
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, ContactSolution
from scenes.array_types import Array
from scenes.solution import range_of_slip

# Relative difference of two sizes that is round-off: engines repeat themselves to 1e-11.
_RELATIVE_ROUND_OFF = 1e-9
# A dissipation of the reference below this share of A f^2 P_ref^2 is the round-off of a sum whose
# true value is 0.
_NEGLIGIBLE_SHARE_OF_WORK = 1e-12
# An amount of the reference below this share of its scale counts as 0.
_NEGLIGIBLE_SHARE = 1e-12
# On the points of an external result, theory's largest value misses its true largest value by some
# share. Above this share the points are too few for a comparison.
_LARGEST_SHARE_MISSED = 0.1
# Below this share both values have the same digits in a table.
_LEAST_VISIBLE_SHARE = 1e-6
# Round-off of the slip of finite elements, over their largest slip: compliances are factorised.
_ROUND_OFF_OF_SLIP = 1e-11
# Stick edges within this distance of the contact edges, over a_ref, are the contact edges.
_EDGE_TOLERANCE = 1e-9

_REASON_TOO_LIGHT = "no instant carries enough load to be judged"
_REASON_NO_CONTACT = "no instant has points in contact in both"
_REASON_NO_SLIP_RESOLVED = (
    "no node of the finite elements slips by more than round-off while it is in contact: what"
    " slips is narrower than an element; make edge_element_size smaller"
)
_REASON_NO_LOOP = "the path is not periodic: no loop"
_REASON_NO_DATUM = "no datum: c_t of these bodies is not known"
_NOTE_ON_COMPLIANCES = "with c_t, c_n of these bodies"


@dataclass(frozen=True, eq=False, kw_only=True)
class MetricValue(PythonNumbers):
    """The value of a metric in one comparison, with its place and time, uncertainty and note.

    Attributes
    ----------
    value
        of the last cycle; of a metric with a value at every instant, the worst. None where there is
        nothing to compare; not finite where the data is not
    time
        instant of the worst value; None for a value of the whole cycle
    series
        (k,) values at the instants of the last cycle (NaN: nothing to compare), or None
    note
        a text that a reader must not miss; where there is no value, the reason
    elements
        value in local element sizes of the result, where it states one
    absolute
        whether the difference is over a fixed scale, since the reference's own value is 0
    place
        where on the surface the worst value is, x/a_ref; None for what has no place
    uncertainty
        of the value, in its unit: by the error budget, else as the engines state it; None where
        neither states one
    amounts
        (reference, result): the quantity itself in both solutions, such as the largest pressure, in
        units of the scene; None for a metric that has none
    stated
        uncertainties that reference and result themselves state of their amounts, in the same
        units: 0 exact, NaN no estimate, None from a solution that states nothing
    denominator
        number that the difference of the two amounts is divided by, in their unit
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

        >>> measured = MetricValue(amounts=(4.0, 3.6), stated=(0.0, 0.2), denominator=4.0)
        >>> measured.stated_by_result, measured.stated_by_reference
        (0.05, 0.0)
        """
        return self._in_unit_of_value(self.stated[1])

    @property
    def stated_by_reference(self) -> float | None:
        """Uncertainty that the reference states of its amount, in the unit of the value; None where
        it states none.
        """
        return self._in_unit_of_value(self.stated[0])

    @property
    def is_on_points_of_result(self) -> bool:
        """Whether the metric compares result and reference on the result's points and instants. The
        amount of the reference may lie between these.

        `amounts` holds the quantity itself in reference and result, such as the largest pressure.
        `value` is a difference over `denominator`. It was taken on the result's points where it is
        not that of the two amounts, to 1e-6 of the larger. False without a value or amounts.

        >>> MetricValue(value=0.0, amounts=(4.0, 3.9), denominator=3.9).is_on_points_of_result
        True
        """
        if self.value is None or self.amounts is None or self.denominator is None:
            return False
        reference_amount, result_amount = self.amounts
        difference = self.value * self.denominator
        mismatch = abs(result_amount - reference_amount - difference)
        return mismatch > _LEAST_VISIBLE_SHARE * max(abs(reference_amount), abs(result_amount))

    def _in_unit_of_value(self, uncertainty: float | None) -> float | None:
        """Uncertainty of an amount, in the unit of the value; None where there is no estimate."""
        if uncertainty is None or not math.isfinite(uncertainty) or self.denominator is None:
            return None
        return uncertainty / abs(self.denominator)


# ------------------------------------------------------------------------- norms, shares, the worst


def l2_norm(x: Array, values: Array) -> Array:
    """L2 norm over x, sqrt(int values^2 dx) by the trapezoidal rule: (..., n) -> (...)."""
    return np.sqrt(np.trapezoid(np.square(values), x, axis=-1))


def quotient(numerator: Array, denominator: Array) -> Array:
    """Quotient; 0/0 is NaN ("nothing to compare"), anything else over 0 is infinite."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.asarray(numerator / denominator, dtype=float)


def trapezoidal_weights(positions: Array) -> Array:
    """Weights of the trapezoidal rule on the points or instants `positions`, (n,) -> (n,). Where
    all of `positions` are equal, each weight is 1.

    >>> (
    ...     trapezoidal_weights(np.array([0.0, 1.0, 3.0])).tolist(),
    ...     trapezoidal_weights(np.array([2.0])).tolist(),
    ... )
    ([0.5, 1.5, 1.0], [1.0])
    """
    if positions[-1] == positions[0]:
        return np.ones(len(positions))
    spacings = np.diff(positions)
    spacing_after_position = np.concatenate([spacings, [0.0]])
    spacing_before_position = np.concatenate([[0.0], spacings])
    return np.asarray(spacing_before_position + spacing_after_position) / 2


def _first_index_of_largest(size: Array) -> int:
    """The first index at which `size` (k,) is largest, to a relative round-off of 1e-9.

    A cycle that is its own mirror image has each difference twice, with both signs: which of them
    is larger is chance.
    """
    is_largest = size >= (1 - _RELATIVE_ROUND_OFF) * size.max()
    return int(np.argmax(is_largest))


def _worst_value_and_place(
    series: Array, is_considered: Mask, places: Array
) -> tuple[float | None, float | None]:
    """The value of largest size in a series, and the time or x at which it stands; the first where
    several are as large. A NaN counts as largest; (None, None) where no value is considered.

    Parameters
    ----------
    series
        (k,) values
    is_considered
        (k,) whether a value is considered
    places
        (k,) time of each value, or its x on the surface

    Examples
    --------
    >>> is_considered = np.array([True, True, False])
    >>> _worst_value_and_place(np.array([1.0, -3.0, 9.0]), is_considered, np.array([0.0, 0.5, 1.0]))
    (-3.0, 0.5)
    """
    if not is_considered.any():
        return None, None
    sizes = np.where(np.isnan(series), np.inf, np.abs(series))
    # -1 is below every size
    worst_index = _first_index_of_largest(np.where(is_considered, sizes, -1.0))
    return float(series[worst_index]), float(places[worst_index])


def _value_at_worst_instant(
    pair: Pair, series: Array, is_considered: Mask | None = None, **further_fields: Any
) -> MetricValue:
    """A metric that is a series over the last cycle, `series` (k,): its value is the entry of
    largest size at the instants `is_considered` (k,), with the time of that entry.

    By default those instants count that are in contact with a normal load of at least a tenth of
    the reference load. `further_fields` are those of `MetricValue`, such as a note.
    """
    if is_considered is None:
        is_considered = pair.is_judged  # in contact, and loaded enough
    value, worst_time = _worst_value_and_place(series, is_considered, pair.result_cycle.time)
    return MetricValue(value=value, time=worst_time, series=series, **further_fields)


def _metric_without_value(reason: str) -> MetricValue:
    """A metric without a value, with the reason in words."""
    return MetricValue(value=None, note=reason)


# -------------------------------------------------------------------------------- absolute values


def _difference_of_amounts(
    reference_amount: float, result_amount: float, scale: float, **further_fields: Any
) -> MetricValue:
    """A metric of two amounts of the same quantity: (result − reference)/reference.

    Where the amount of the reference is at most 1e-12 of `scale`, which counts as 0, the difference
    is divided by `scale`, and the metric is marked `absolute`.

    Parameters
    ----------
    reference_amount, result_amount
        the quantity in reference and result, in units of the scene
    scale
        a typical size of the quantity, in the same units
    further_fields
        further fields of `MetricValue`, such as a note
    """
    is_absolute = abs(reference_amount) <= _NEGLIGIBLE_SHARE * scale
    denominator = scale if is_absolute else reference_amount
    return MetricValue(
        value=(result_amount - reference_amount) / denominator,
        absolute=is_absolute,
        amounts=(reference_amount, result_amount),
        denominator=denominator,
        **further_fields,
    )


def _difference_of_extremes(
    extremum: float,
    value_on_points: float,
    value_of_result: float,
    scale: float,
    *,
    is_external: bool,
    note: str = "",
) -> MetricValue:
    """Compare an extreme value of result and reference, such as the largest pressure: (result −
    reference)/reference.

    An external result has points and instants of its own choice, which may miss the extremum. It is
    therefore compared with the reference on the same points and instants, and a note says so where
    that changes more than 1e-6 of it. There is no value where these points miss more than a tenth
    of the reference's extremum. None either where the reference is infinite and the result finite.

    Parameters
    ----------
    extremum, value_on_points
        extreme value of the reference: over its whole surface and cycle, and on the points and
        instants of the result
    value_of_result
        extreme value of the result
    scale
        typical size of the quantity, which divides the difference where the extremum of the
        reference is below 1e-12 of it
    is_external
        whether the result comes from another program
    note
        note of the metric where no other note is needed
    """
    amounts = (extremum, value_of_result)
    if math.isinf(extremum) and math.isfinite(value_of_result):
        return MetricValue(value=None, note="infinite in the reference", amounts=amounts)
    if not is_external:
        return _difference_of_amounts(extremum, value_of_result, scale, note=note)
    denominator = abs(extremum) if abs(extremum) > _NEGLIGIBLE_SHARE * scale else scale
    # part of the extremum that lies between the points and instants of the result
    share_missed = abs(value_on_points - extremum) / denominator
    if share_missed > _LARGEST_SHARE_MISSED:
        reason_for_no_value = (
            "the result's points and instants are too few: on them the reference has"
            f" {value_on_points:.4g}"
            f" in place of {extremum:.4g}"
        )
        return MetricValue(value=None, note=reason_for_no_value, amounts=amounts)
    if share_missed > _LEAST_VISIBLE_SHARE:
        note = (
            "the difference is that on the result's points and instants, where the reference has"
            f" {value_on_points:.5g}"
        )
    metric_value = _difference_of_amounts(value_on_points, value_of_result, scale, note=note)
    return replace(metric_value, amounts=amounts)


def _difference_of_largest_values(
    pair: Pair, name: str, value_on_points: float, value_of_result: float, scale: float
) -> MetricValue:
    """Compare the largest value of a quantity in result and reference: (result −
    reference)/reference.

    Half-plane theory states its largest value over the whole surface and cycle. Of another
    reference, corrected theory too, the largest value at the common points and instants is taken.

    Parameters
    ----------
    pair
        the two solutions. `theory_extremes`: largest values of theory, and in `sampled` why they
        are not exact ("" where they are); None where the reference is not theory.
        `has_external_result`: whether the result is not of the project's finite elements
    name
        the quantity in `pair.theory_extremes`: "pressure", "half_width", "slip" or
        "dissipation_density"
    value_on_points, value_of_result
        largest value of the reference and of the result at the common points and instants
    scale
        typical size of the quantity, which divides the difference where the reference has 0
    """
    extremum = value_on_points
    note = ""
    if pair.theory_extremes is not None:
        extremum = getattr(pair.theory_extremes, name)
        note = pair.theory_extremes.sampled
    is_external = pair.has_external_result
    return _difference_of_extremes(
        extremum, value_on_points, value_of_result, scale, is_external=is_external, note=note
    )


def _with_stated_uncertainties(
    pair: Pair, metric_value: MetricValue, name: str, name_of_error: str = ""
) -> MetricValue:
    """The value of a metric, `metric_value`, with `stated` filled in: the uncertainties that
    reference and result themselves state of the two `amounts` that it compares, in their unit.
    Unchanged where the metric has no amounts.

    Parameters
    ----------
    pair
        the two solutions. `plain_reference`: the reference by its own rules, not by those of an
        external result
    name
        key of the quantity among the uncertainties that a solution states
    name_of_error
        key of the quantity among the relative errors that half-plane theory states; "" where
        theory is exact
    """
    if metric_value.amounts is None:
        return metric_value
    reference_amount, result_amount = metric_value.amounts
    stated_uncertainties = (
        stated_uncertainty(pair.plain_reference, reference_amount, name, name_of_error),
        stated_uncertainty(pair.result, result_amount, name, name_of_error),
    )
    return replace(metric_value, stated=stated_uncertainties)


def _place_of_largest_value(pair: Pair, values: Array) -> float:
    """x/a_ref of the point with the largest of `values` (n,)."""
    return float(pair.result_cycle.x[np.argmax(values)]) / pair.scales.half_width


def largest_pressure(pair: Pair) -> MetricValue:
    """Largest pressure p of the cycle, (result − reference)/reference."""
    reference_amount = float(pair.reference_cycle.pressure.max())
    result_amount = float(pair.result_cycle.pressure.max())
    metric_value = _difference_of_largest_values(
        pair, "pressure", reference_amount, result_amount, pair.scales.pressure
    )
    return _with_stated_uncertainties(pair, metric_value, "largest_pressure", "pressure")


def largest_half_width(pair: Pair) -> MetricValue:
    """Largest half distance of the contact edges in the cycle, (result − reference)/reference."""
    reference_amount = _largest_half_distance(pair.reference_cycle)
    result_amount = _largest_half_distance(pair.result_cycle)
    metric_value = _difference_of_largest_values(
        pair, "half_width", reference_amount, result_amount, pair.scales.half_width
    )
    return _with_stated_uncertainties(pair, metric_value, "largest_half_width")


def _largest_half_distance(cycle: Cycle) -> float:
    """Largest half distance of the contact edges in a cycle [length]; 0 without contact."""
    return float(np.nanmax(np.diff(cycle.contact_edges, axis=1), initial=0.0)) / 2


def permanent_stick(pair: Pair) -> MetricValue:
    """Half-width of the zone that sticks through the whole cycle, result − reference over a_ref."""
    metric_value = _difference_of_stick_zones(pair, _permanent_half_width)
    return _with_stated_uncertainties(pair, metric_value, "permanent_stick_half_width")


def stick_eccentricity(pair: Pair) -> MetricValue:
    """Middle x of the zone that sticks through the whole cycle, result − reference over a_ref."""
    metric_value = _difference_of_stick_zones(pair, _middle_of_stick)
    # Half the sum of two edges is as uncertain as half their distance.
    return _with_stated_uncertainties(pair, metric_value, "permanent_stick_half_width")


def _permanent_half_width(solution: ContactSolution) -> float:
    """Half-width of the zone that sticks through the whole cycle [length]; NaN without one."""
    return solution.permanent_stick_half_width


def _middle_of_stick(solution: ContactSolution) -> float:
    """Middle x of the zone that sticks through the whole cycle [length]; NaN without one."""
    edges = solution.permanent_stick_edges
    return math.nan if edges is None else float(np.mean(edges))


def _difference_of_stick_zones(
    pair: Pair, length_of: Callable[[ContactSolution], float]
) -> MetricValue:
    """A length of the zone that sticks through the whole cycle, result − reference over a_ref.

    The states (stick, slip) of the reference may follow the rule by which those of an external
    result were found. The amount of the reference is that by its own rule, from
    `pair.plain_reference`.

    `length_of` takes the length from a solution, such as the half-width of the zone [length]; NaN
    means that there is no such zone. No value where one solution lacks the zone or both do: the
    note then names them.
    `pair.scales.half_width` is a_ref, the half-width of contact at the reference load.
    """
    reference_length = float(length_of(pair.reference))
    result_length = float(length_of(pair.result))
    # the quantity itself in reference and result, which a table shows
    amounts = (float(length_of(pair.plain_reference)), result_length)
    if math.isnan(reference_length) and math.isnan(result_length):
        engines = (
            f"{engine_in_words(pair.reference.engine)} and {engine_in_words(pair.result.engine)}"
        )
        return _metric_without_value(f"none in {engines}")
    if math.isnan(reference_length):
        return MetricValue(
            note=f"none in {engine_in_words(pair.reference.engine)}", amounts=amounts
        )
    if math.isnan(result_length):
        return MetricValue(note=f"none in {engine_in_words(pair.result.engine)}", amounts=amounts)
    return MetricValue(
        value=(result_length - reference_length) / pair.scales.half_width,
        amounts=amounts,
        denominator=pair.scales.half_width,
    )


def largest_slip(pair: Pair) -> MetricValue:
    """Largest range of the slip s that any place has while in contact, each solution over its own
    contact: (result − reference)/reference. Of finite elements the places between nodes count too.

    No value where the finite elements slip by no more than round-off (1e-11 of their largest s) and
    the reference by more; none without friction, or where the result never has contact. Where the
    reference does not slip, the difference is over f p_ref a_ref/E* (`pair.scales.slip`).

    # notation: f friction coefficient, p_ref and a_ref pressure and half-width at the reference
    # load, E* contact modulus
    """
    # last cycles: slip s [length] and state (open, stick, slip) of the common points, (k, n)
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    if not pair.result.scene.friction.coefficient:
        return _metric_without_value("nothing resists slip")
    is_closed_in_result = result_cycle.state != OPEN
    is_closed_in_reference = reference_cycle.state != OPEN
    if not is_closed_in_result.any():
        # _REASON_...: texts that become the note of a metric without a value
        return _metric_without_value(_REASON_NO_CONTACT)
    reference_amount, _ = _largest_slip_of_cycle(pair, reference_cycle, is_closed_in_reference)
    result_amount, place = _largest_slip_of_cycle(pair, result_cycle, is_closed_in_result)
    # `amounts` of the metric: the largest slip itself, in reference and result
    metric_value = _difference_of_largest_values(
        pair, "slip", reference_amount, result_amount, pair.scales.slip
    )
    metric_value = _with_stated_uncertainties(pair, metric_value, "largest_slip", "slip")
    if pair.result.engine == "halfplane_fe" and metric_value.amounts is not None:
        # Where all slip is round-off the slip zone is narrower than an element.
        round_off = _ROUND_OFF_OF_SLIP * float(np.max(np.abs(result_cycle.slip)))
        if result_amount <= round_off < metric_value.amounts[0]:
            return replace(metric_value, value=None, note=_REASON_NO_SLIP_RESOLVED)
    return replace(metric_value, place=place / pair.scales.half_width)


def _largest_slip_of_cycle(pair: Pair, cycle: Cycle, is_closed: Mask) -> tuple[float, float]:
    """Largest range of slip through a cycle, and its place x; `is_closed` (k, n) states whether a
    point is in contact at an instant.

    Finite elements, and a reference at their nodes, are continued to places between the nodes, up
    to the edges of contact. An external result knows its own points alone: beside it these count.
    """
    import halfplane_fe

    if not pair.has_external_result:
        largest = halfplane_fe.largest_slip_of_cycle(
            cycle.x, cycle.slip, is_closed, cycle.contact_edges
        )
        return largest.value, largest.x
    slip_ranges = range_of_slip(cycle.slip, is_closed)
    point = int(np.argmax(slip_ranges))
    return float(slip_ranges[point]), float(cycle.x[point])


def largest_slip_common(pair: Pair) -> MetricValue:
    """Largest range of the slip s that any point has, over the points and instants in contact in
    both solutions: (result − reference)/reference. No value without such a point. Where the
    reference does not slip, the difference is over f p_ref a_ref/E* (`pair.scales.slip`).

    # notation: f friction coefficient, p_ref and a_ref pressure and half-width at the reference
    # load, E* contact modulus
    """
    is_closed = _is_closed_in_both(pair)  # (k instants, n points)
    if not is_closed.any():
        return _metric_without_value(_REASON_NO_CONTACT)
    # largest minus least s of each point over its instants in contact, (n,)
    ranges_in_reference = range_of_slip(pair.reference_cycle.slip, is_closed)
    ranges_in_result = range_of_slip(pair.result_cycle.slip, is_closed)
    return _difference_of_amounts(
        float(ranges_in_reference.max()),
        float(ranges_in_result.max()),
        pair.scales.slip,
        place=_place_of_largest_value(pair, ranges_in_result),
    )


def _is_closed_in_both(pair: Pair) -> Mask:
    """(k, n) whether a point is in contact at an instant, in reference and result."""
    return np.asarray((pair.reference_cycle.state != OPEN) & (pair.result_cycle.state != OPEN))


def dissipation(pair: Pair) -> MetricValue:
    """Friction work W of the last cycle, (result − reference)/reference. Over A f^2 P_ref^2 and
    marked `absolute` where the reference dissipates nothing.

    An external result is compared with W of `pair.reference`, which integrates by the same rule and
    on the same points as the result. The table shows the W of `pair.plain_reference`, the same
    solution with its own rule and points. `pair.scales.dissipation` is A f^2 P_ref^2.

    # notation: A = 2/E* compliance of the materials (E* contact modulus), f friction coefficient,
    # P_ref reference load
    """
    # the two W of the reference differ for an external result only
    metric_value = _difference_of_extremes(
        pair.plain_reference.dissipation,
        pair.reference.dissipation,
        pair.result.dissipation,
        pair.scales.dissipation,
        is_external=pair.plain_reference is not pair.reference,
    )
    metric_value = _with_stated_uncertainties(pair, metric_value, "dissipation", "dissipation")
    if metric_value.absolute:
        note = "the reference dissipates nothing, so the value is absolute"
        return replace(metric_value, note=note)
    return metric_value


def largest_dissipation_density(pair: Pair) -> MetricValue:
    """Largest friction work per area w(x) of the last cycle: (result − reference)/reference, with
    the place x/a_ref of the result's largest value. Over A f^2 P_ref^2/a_ref
    (`pair.scales.dissipation_density`) where the reference does no friction work.

    # notation: A = 2/E* compliance of the materials (E* contact modulus), f friction coefficient,
    # P_ref reference load, a_ref half-width at it
    """
    # last cycles: `dissipation_density` is w at the common points, (n,)
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    reference_amount = float(reference_cycle.dissipation_density.max())
    result_amount = float(result_cycle.dissipation_density.max())
    metric_value = _difference_of_largest_values(
        pair,
        "dissipation_density",
        reference_amount,
        result_amount,
        pair.scales.dissipation_density,
    )
    metric_value = _with_stated_uncertainties(
        pair, metric_value, "largest_dissipation_density", "dissipation_density"
    )
    return replace(
        metric_value, place=_place_of_largest_value(pair, result_cycle.dissipation_density)
    )


def edge_tension(pair: Pair) -> MetricValue:
    """Largest tensile stress along a face at an edge of contact, (result − reference)/reference.

    Where the stress of the reference is negligible beside f p_ref (`pair.scales.shear`), friction
    coefficient times reference pressure, the difference is over f p_ref. The uncertainty of the
    metric is the sum of those that both solutions report, over the same scale. No value without
    friction, or where one solution does not report that stress. The reference counts with its own
    stick and slip states and edges (`pair.plain_reference`), not with those by a rule of the
    result.
    """
    if not pair.result.scene.friction.coefficient:
        return _metric_without_value("frictionless: nothing stretches the faces")
    # (stress, its uncertainty), or None
    tension_of_reference = _largest_tension_and_uncertainty(pair.plain_reference, pair)
    tension_of_result = _largest_tension_and_uncertainty(pair.result, pair)
    if tension_of_reference is None or tension_of_result is None:
        return _metric_without_tension(pair, tension_of_reference, tension_of_result)

    reference_amount, reference_uncertainty = tension_of_reference
    result_amount, result_uncertainty = tension_of_result
    # (result − reference)/reference; `absolute`: over f p_ref
    metric_value = _difference_of_amounts(reference_amount, result_amount, pair.scales.shear)
    scale = pair.scales.shear if metric_value.absolute else abs(reference_amount)
    relative_uncertainty = (reference_uncertainty + result_uncertainty) / scale
    stated_uncertainties = (reference_uncertainty, result_uncertainty)
    return replace(metric_value, uncertainty=relative_uncertainty, stated=stated_uncertainties)


def _metric_without_tension(
    pair: Pair,
    tension_of_reference: tuple[float, float] | None,
    tension_of_result: tuple[float, float] | None,
) -> MetricValue:
    """The metric of the largest tension where a solution does not state it: no value, and the
    amount of the other solution. A tension is a pair (value, uncertainty) [stress] or None.
    """
    from halfplane_fe.body_fields import why_tension_is_unknown

    unknown_tension = (math.nan, math.nan)
    reference_amount, reference_uncertainty = tension_of_reference or unknown_tension
    result_amount, result_uncertainty = tension_of_result or unknown_tension
    engines_without_value = []
    if tension_of_reference is None:
        engines_without_value.append(engine_in_words(pair.reference.engine))
    if tension_of_result is None:
        engines_without_value.append(engine_in_words(pair.result.engine))
    note = f"not known of {' and '.join(engines_without_value)}"
    if tension_of_result is None and pair.result.engine == "halfplane_fe":
        # such as bodies whose stress beside the contact cannot be fitted; None for another reason
        reason = why_tension_is_unknown(pair.result)
        note = f"{note}: {reason}" if reason else note
    return replace(
        _metric_without_value(note),
        amounts=(reference_amount, result_amount),
        stated=(reference_uncertainty, result_uncertainty),
    )


def _largest_tension_and_uncertainty(
    solution: ContactSolution, pair: Pair
) -> tuple[float, float] | None:
    """Largest tensile stress along a face at an edge of contact, and its uncertainty [stress]; None
    where the solution does not state it: an external one, theory corrected by the responses of
    finite bodies, or theory that is compared with a reference which is not theory.

    `solution` is reference or result of `pair`.
    """
    import halfplane_fe

    if solution.engine == "semi_analytic":
        # largest values of theory in the cycle; None where the reference is not plain theory
        extremes = pair.theory_extremes
        if extremes is None or is_corrected(solution):
            return None
        return extremes.edge_tension, extremes.edge_tension_uncertainty
    if solution.engine != "halfplane_fe":
        return None
    largest_tension = halfplane_fe.largest_edge_tension(solution)
    return None if largest_tension is None else (largest_tension.value, largest_tension.uncertainty)


# ------------------------------------------------------------------------------- pressure and shear


def peak_pressure(pair: Pair) -> MetricValue:
    """Largest pressure p of an instant, (result − reference)/reference, at the worst instant.

    Both maxima are over the same points, so that the distance of the points from the true peak
    cancels. With the reference's true peak every result would look too low, by up to (h/a)^2/8,
    h the spacing of the points, a the half-width of contact.
    """
    reference_peak = pair.reference_cycle.pressure.max(axis=1)
    result_peak = pair.result_cycle.pressure.max(axis=1)
    return _value_at_worst_instant(pair, quotient(result_peak - reference_peak, reference_peak))


def pressure(pair: Pair) -> MetricValue:
    """L2 norm over x of the difference of the pressures, over that of the reference's pressure, at
    the worst instant. `stated` holds the relative uncertainties that both solutions state.
    """
    # last cycles: pressure at the common instants and points, (k, n)
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    x = result_cycle.x
    difference = l2_norm(x, result_cycle.pressure - reference_cycle.pressure)
    series = quotient(difference, l2_norm(x, reference_cycle.pressure))
    # denominator 1: the stated uncertainties are relative already
    return _value_at_worst_instant(
        pair, series, stated=_stated_uncertainties_of_norm(pair, "pressure"), denominator=1.0
    )


def shear(pair: Pair) -> MetricValue:
    """L2 norm over x of the difference of the shear tractions, over f times that of the reference's
    pressure, at the worst instant. `stated` holds the relative uncertainties that both solutions
    state.
    """
    # last cycles: tractions at the common instants and points, (k, n)
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    x = result_cycle.x
    difference = l2_norm(x, result_cycle.shear - reference_cycle.shear)
    series = quotient(difference, pair.scales.friction * l2_norm(x, reference_cycle.pressure))
    # denominator 1: the stated uncertainties are relative already
    return _value_at_worst_instant(
        pair, series, stated=_stated_uncertainties_of_norm(pair, "shear"), denominator=1.0
    )


def _stated_uncertainties_of_norm(pair: Pair, name: str) -> tuple[float | None, float | None]:
    """Relative uncertainty in the L2 norm that reference and result state of a traction, `name`
    being "pressure" or "shear".
    """
    return (
        stated_uncertainty(pair.plain_reference, 1.0, name, name),
        stated_uncertainty(pair.result, 1.0, name, name),
    )


def normal_resultant(pair: Pair) -> MetricValue:
    """P that the tractions of the result carry, minus P that it states, over P."""
    return _excess_of_resultant(pair, _normal_resultant, "normal_load")


def tangential_resultant(pair: Pair) -> MetricValue:
    """Q that the tractions of the result carry, minus Q that it states, over P."""
    return _excess_of_resultant(pair, _tangential_resultant, "tangential_load")


def _normal_resultant(cycle: Cycle, face_lengths: Array, normals: Array) -> Array:
    """Normal load P that the tractions of a cycle carry at each instant, (k,) [force / thickness].

    Parameters
    ----------
    cycle
        `pressure` and `shear` (k, n) at its instants and points [stress]
    face_lengths
        (n,) length of the face that belongs to each point [length]
    normals
        (2, n) components (x, y) of the unit normal n out of the lower body: on that body the
        pressure acts against it, positive shear along (n_y, -n_x)
    """
    normal_x, normal_y = normals
    resultant = np.asarray(cycle.pressure @ (face_lengths * normal_y))
    # On a flat face the shear has no part in P. It may be absent, that is NaN, and NaN times 0 is
    # NaN.
    if normal_x.any():
        resultant = resultant + cycle.shear @ (face_lengths * normal_x)
    return resultant


def _tangential_resultant(cycle: Cycle, face_lengths: Array, normals: Array) -> Array:
    """Tangential load Q that the tractions of a cycle carry at each instant, (k,)
    [force / thickness].

    Parameters
    ----------
    cycle
        `pressure` and `shear` (k, n) at its instants and points [stress]
    face_lengths
        (n,) length of the face that belongs to each point [length]
    normals
        (2, n) components (x, y) of the unit normal n out of the lower body: on that body the
        pressure acts against it, positive shear along (n_y, -n_x)
    """
    normal_x, normal_y = normals
    return np.asarray(
        cycle.shear @ (face_lengths * normal_y) - cycle.pressure @ (face_lengths * normal_x)
    )


def _faces_of_result(result: ContactSolution) -> tuple[Array, Array] | None:
    """Length of the lower face at each point of a result, (n,) [length], and the unit normal out of
    it, (2, n). None for a result that is no finite-element solution, or was read from a file.
    """
    if result.engine != "halfplane_fe":
        return None
    from halfplane_fe.solution import FiniteElementSolution

    if not isinstance(result, FiniteElementSolution):
        return None
    return result.face_lengths, result.face_normals


def _excess_of_resultant(
    pair: Pair, resultant_of: Callable[[Cycle, Array, Array], Array], name_of_load: str
) -> MetricValue:
    """Load that the result's tractions carry minus load that the result states, over P, at the
    worst instant: a check of equilibrium.

    A finite-element result states the length of the face at each of its points, and the normal.
    Otherwise the tractions are integrated by the trapezoidal rule. The error of that rule, known
    from the reference, is then subtracted.

    Parameters
    ----------
    pair
        the two solutions, with their last cycles on k common instants and n common points
    resultant_of
        integrates tractions, (cycle, face lengths (n,), normals (2, n)) -> load (k,)
    name_of_load
        name of the stated load (k,) in a cycle, "normal_load" or "tangential_load"
    """
    x = pair.result_cycle.x
    trapezoidal_lengths = trapezoidal_weights(x)
    normals_of_flat = np.array([np.zeros_like(x), np.ones_like(x)])
    # lengths and normals of the finite elements; None for another result
    faces = _faces_of_result(pair.result)
    lengths_of_points, normals_of_points = faces or (trapezoidal_lengths, normals_of_flat)
    resultant = resultant_of(pair.result_cycle, lengths_of_points, normals_of_points)
    excess = resultant - getattr(pair.result_cycle, name_of_load)
    note = ""
    if faces is None:
        resultant_of_reference = resultant_of(
            pair.reference_cycle, trapezoidal_lengths, normals_of_flat
        )
        error_of_rule = resultant_of_reference - getattr(pair.reference_cycle, name_of_load)
        excess = excess - error_of_rule
        note = (
            "the result states no weights, so by the trapezoidal rule, minus its error for the"
            " reference"
        )
    return _value_at_worst_instant(pair, quotient(excess, pair.result_cycle.normal_load), note=note)


# -------------------------------------------------------------------------- contact, stick and slip


def contact_edge(pair: Pair) -> MetricValue:
    """Outward shift of the worse contact edge over a_ref, at the worst instant."""
    shift = _outward_shift_of_worse_edge(
        pair.reference_cycle.contact_edges, pair.result_cycle.contact_edges
    )
    metric_value = _value_at_worst_instant(pair, shift / pair.scales.half_width)
    return replace(metric_value, elements=_shift_in_elements(pair, metric_value.value))


def stick_edge(pair: Pair) -> MetricValue:
    """Outward shift of the worse edge of the stick zone over a_ref, the half-width at the reference
    load. It is that at the worst of the judged instants at which both solutions have a stick zone.

    Not compared is an instant at which full stick comes or goes one instant earlier in one of them,
    and one at which the reference has several stick zones: finite elements state the ends of the
    main one, theory on grids those of all. The note counts these, and the instants at which the two
    differ in full stick, partial slip or full slip. NaN, which fails, where they differ and no
    instant remains; no value where both always slip fully.
    Judged are instants in contact with a normal load of at least a tenth of the reference load
    (`pair.is_judged`, (k,)).
    """
    # last cycles: `stick_edges` (k, 2), left and right, at the common instants
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    half_width = pair.scales.half_width  # a_ref
    # (k,) status of the whole contact: full stick, partial slip, full slip or out of contact
    status_of_reference = _stick_status(reference_cycle, half_width)
    status_of_result = _stick_status(result_cycle, half_width)
    shift = _outward_shift_of_worse_edge(reference_cycle.stick_edges, result_cycle.stick_edges)
    has_several_zones = _has_several_stick_zones(reference_cycle)
    is_compared = pair.is_judged & ~has_several_zones
    is_compared &= _has_comparable_stick_edges(status_of_reference, status_of_result)
    metric_value = _value_at_worst_instant(pair, shift / half_width, is_compared)

    n_judged = int(pair.is_judged.sum())
    n_with_several_zones = int(has_several_zones[pair.is_judged].sum())
    n_differing = int((status_of_reference != status_of_result)[pair.is_judged].sum())
    notes = []
    if n_with_several_zones:
        notes.append(f"{n_with_several_zones} of {n_judged} instants have several stick zones")
    if n_differing:
        notes.append(
            f"{n_differing} of {n_judged} instants differ in full stick, partial slip or full slip"
        )
    note = "; ".join(notes)
    if metric_value.value is None and n_differing:
        reason_for_no_value = f"no instant has a stick edge in both: {note}"
        return replace(metric_value, value=math.nan, note=reason_for_no_value)
    # with the shift in element sizes too
    return replace(metric_value, note=note, elements=_shift_in_elements(pair, metric_value.value))


def _outward_shift_of_worse_edge(reference_edges: Array, result_edges: Array) -> Array:
    """Outward shift of the edge, left or right, that differs more, (k,) from (k, 2); NaN where a
    solution lacks an edge.

    >>> _outward_shift_of_worse_edge(np.array([[-1.0, 1.0]]), np.array([[-1.02, 1.01]])).round(
    ...     12
    ... ).tolist()
    [0.02]
    """
    outward_shift = (result_edges - reference_edges) * np.array([-1.0, 1.0])
    worse_edge = np.argmax(np.abs(outward_shift), axis=1)  # 0 left, 1 right; of a NaN its edge
    return np.asarray(outward_shift[np.arange(len(outward_shift)), worse_edge])


def _shift_in_elements(pair: Pair, value: float | None) -> float | None:
    """Shift of an edge in element sizes, from its `value` over a_ref; None without a value, or
    where the result states no element size.
    """
    element_size = pair.result.settings.get("element_size")  # [length]
    if not element_size or value is None:
        return None
    return value * pair.scales.half_width / float(element_size)


# Fewest points that slip between two stick zones: one or two may do so by round-off.
_SEVERAL_POINTS = 3
_FULL_SLIP = 0
_PARTIAL_SLIP = 1
_FULL_STICK = 2
_OUT_OF_CONTACT = -1


def _stick_status(cycle: Cycle, half_width: float) -> NDArray[np.int8]:
    """Status of the whole contact at each instant, (k,): 0 full slip, 1 partial slip, 2 full stick,
    -1 out of contact.

    Full stick: the stick edges are the contact edges (to 1e-9 `half_width`). Full slip: they are
    NaN. Out of contact: no point carries pressure. Edges of a cycle are (k, 2), left and right.
    """
    distance = np.max(np.abs(cycle.stick_edges - cycle.contact_edges), axis=1)
    status = np.where(distance <= _EDGE_TOLERANCE * half_width, _FULL_STICK, _PARTIAL_SLIP)
    status[np.isnan(distance)] = _FULL_SLIP
    is_in_contact = cycle.pressure.max(axis=1) > 0
    return np.where(is_in_contact, status, _OUT_OF_CONTACT).astype(np.int8)


def _has_several_stick_zones(cycle: Cycle) -> Mask:
    """(k,) instants at which the contact has several stick zones, as it may under bulk stress and
    tilt together: at least three points slip between the first and the last that stick.

    `cycle` has the states (k, n) of n points at ascending x.
    """
    sticks = cycle.state == STICK
    slips = (cycle.state == SLIP_FORWARD) | (cycle.state == SLIP_REVERSE)
    has_stick_before = np.logical_or.accumulate(sticks, axis=1)
    has_stick_behind = np.logical_or.accumulate(sticks[:, ::-1], axis=1)[:, ::-1]
    n_slipping_between = np.count_nonzero(slips & has_stick_before & has_stick_behind, axis=1)
    # _SEVERAL_POINTS: fewest points that part two zones
    return np.asarray(n_slipping_between >= _SEVERAL_POINTS)


def _has_comparable_stick_edges(
    status_of_reference: NDArray[np.int8], status_of_result: NDArray[np.int8]
) -> Mask:
    """(k,) whether the edges of two stick zones can be compared at an instant.

    The arguments are the status of the whole contact in reference and result, (k,): -1 out of
    contact, 0 full slip, 1 partial slip, 2 full stick.

    They can't be compared where one is in full slip, which has no stick edges. Nor can they where
    the two differ because one changes its status an instant earlier: the edge jumps there, which is
    an error of time and not of place. Instants out of contact count as comparable: the caller
    leaves out those where both are, and where one is, the shift is NaN. The first and the last
    instant of a cycle are neighbours.

    >>> _has_comparable_stick_edges(
    ...     np.array([1, 1, 2, 2, 1, 1], dtype=np.int8), np.array([1, 1, 1, 2, 1, 2], dtype=np.int8)
    ... ).tolist()
    [True, True, False, True, True, True]
    """
    both_have_edges = (status_of_reference != _FULL_SLIP) & (status_of_result != _FULL_SLIP)
    is_one_instant_late = (
        (status_of_reference != status_of_result)
        & _equals_neighbour_in_time(status_of_reference, status_of_result)
        & _equals_neighbour_in_time(status_of_result, status_of_reference)
    )
    return np.asarray(both_have_edges & ~is_one_instant_late)


def _equals_neighbour_in_time(status: NDArray[np.int8], other_status: NDArray[np.int8]) -> Mask:
    """(k,) whether `status` equals `other_status` one instant earlier or later."""
    equals_earlier_status = status == np.roll(other_status, 1)
    equals_later_status = status == np.roll(other_status, -1)
    return np.asarray(equals_earlier_status | equals_later_status)


def state(pair: Pair) -> MetricValue:
    """Share of the length in contact, in result or reference, on which their states (stick, slip
    forward or reverse, open) differ, at each instant. The value of the metric is the mean over the
    time in contact; none where that is a single instant or there is no contact.
    """
    # last cycles: `state` (k, n), 0 where a point is open, at the common instants and points
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    lengths = np.gradient(result_cycle.x)  # (n,) of the surface at each point
    is_closed = (reference_cycle.state != OPEN) | (result_cycle.state != OPEN)
    has_other_state = reference_cycle.state != result_cycle.state
    length_in_contact = (is_closed * lengths).sum(axis=1)
    differing_length = (has_other_state * lengths).sum(axis=1)
    share = quotient(differing_length, length_in_contact)
    # instants at which any point carries pressure, in reference or result
    time_in_contact = result_cycle.time[pair.is_in_contact]
    if not len(time_in_contact) or time_in_contact[-1] == time_in_contact[0]:
        return MetricValue(value=None, series=share)
    mean_share = np.trapezoid(share[pair.is_in_contact], time_in_contact) / (
        time_in_contact[-1] - time_in_contact[0]
    )
    return MetricValue(value=float(mean_share), series=share)


def slip(pair: Pair) -> MetricValue:
    """Root mean square over x of the difference of the slips, s − s_ref, divided by the range of
    s_ref, at the worst instant. Only points in contact in both solutions count; no value without
    any.

    Where the range of s_ref is below 1e-12 of f p_ref a_ref/E* (`pair.scales.slip`) the difference
    is divided by f p_ref a_ref/E*, and the metric is marked `absolute`.

    # notation: s_ref slip of the reference, f friction coefficient, p_ref and a_ref pressure and
    # half-width at the reference load, E* contact modulus
    """
    # last cycles: slip s (k, n) [length] at the common instants and points
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    # (k, n) in contact in both: at an open point s is a displacement, and no slip
    is_closed = _is_closed_in_both(pair)
    # judged are instants with a normal load of at least a tenth of the reference load
    is_considered = pair.is_judged & is_closed.any(axis=1)
    if not is_considered.any():
        return _metric_without_value(_REASON_NO_CONTACT)
    range_of_reference = np.ptp(reference_cycle.slip[is_closed])
    is_absolute = bool(range_of_reference <= _NEGLIGIBLE_SHARE * pair.scales.slip)
    scale = pair.scales.slip if is_absolute else range_of_reference
    difference = np.where(is_closed, (result_cycle.slip - reference_cycle.slip) / scale, 0.0)
    length_in_contact = is_closed * trapezoidal_weights(result_cycle.x)
    mean_square = quotient(
        (difference**2 * length_in_contact).sum(axis=1), length_in_contact.sum(axis=1)
    )
    return _value_at_worst_instant(pair, np.sqrt(mean_square), is_considered, absolute=is_absolute)


def moment(pair: Pair) -> MetricValue:
    """Moment M of the pressure about x = 0, result − reference over P_ref a_ref (load and
    half-width of the reference), at the worst instant.
    """
    return _difference_of_series(pair, "moment", pair.scales.moment)


def tilt(pair: Pair) -> MetricValue:
    """Tilt of the upper body, result − reference over A P_ref/a_ref, at the worst instant; A = 2/E*
    is the compliance, P_ref and a_ref are load and half-width of the reference.
    """
    return _difference_of_series(pair, "tilt", pair.scales.tilt)


def _difference_of_series(pair: Pair, name: str, scale: float) -> MetricValue:
    """Difference, result − reference over `scale`, of a series over time at the worst instant; no
    value where a solution does not state the series.
    """
    reference_series = getattr(pair.reference_cycle, name)
    result_series = getattr(pair.result_cycle, name)
    if reference_series is None or result_series is None:
        return _metric_without_value("a solution states none")
    return _value_at_worst_instant(pair, (result_series - reference_series) / scale)


# ---------------------------------------------------------------------------------- work and energy


def tangential_displacement(pair: Pair) -> MetricValue:
    """Tangential displacement U, result − reference over the range of U_ref in the cycle, at the
    worst instant.

    No value where the two solutions count U from different places, or where U_ref does not vary (by
    more than 1e-12 of A f P_ref, `pair.scales.displacement`). None either where no instant carries
    enough load, 0.1 P_ref (`pair.is_judged`). A note says where U of half-planes is given with the
    compliances of the bodies (`pair.effects`).

    # notation: U_ref that of the reference, A = 2/E* compliance of the materials (E* contact
    # modulus), f friction coefficient, P_ref reference load
    """
    if pair.lacks_common_datum:
        return _metric_without_value(_REASON_NO_DATUM)
    reference_displacement = pair.reference_cycle.tangential_displacement
    result_displacement = pair.result_cycle.tangential_displacement
    stroke = float(np.ptp(reference_displacement))
    least_stroke = _NEGLIGIBLE_SHARE * pair.scales.displacement
    if stroke <= least_stroke:
        series_without_values = np.full_like(reference_displacement, np.nan)
        note = "the reference does not move sideways"
        return MetricValue(value=None, series=series_without_values, note=note)
    # A stroke that is NaN must not pass for a stroke of 0: its series is NaN, which fails.
    series = np.full_like(reference_displacement, np.nan)
    if stroke > least_stroke:
        series = (result_displacement - reference_displacement) / stroke
    note = "" if pair.effects is None else _NOTE_ON_COMPLIANCES
    if not pair.is_judged.any():
        note = _REASON_TOO_LIGHT
    return _value_at_worst_instant(pair, series, note=note)


def displacement_amplitude(pair: Pair) -> MetricValue:
    """Half the range of the tangential displacement U in the cycle, (result −
    reference)/reference.
    """
    return _difference_of_amplitudes(pair, "tangential_displacement", "U does not vary")


def approach_amplitude(pair: Pair) -> MetricValue:
    """Half the range of the normal approach in the cycle, (result − reference)/reference."""
    return _difference_of_amplitudes(pair, "normal_approach", "the approach does not vary")


def _difference_of_amplitudes(pair: Pair, name: str, reason_for_no_value: str) -> MetricValue:
    """Amplitude of a displacement, half of its range in the cycle: (result − reference)/reference.

    The metric has no value where a solution does not state the displacement, nor where that of the
    reference does not vary: by less than 1e-12 of a typical displacement. A note says that the
    displacements of half-planes are given with the compliances of the bodies.

    Parameters
    ----------
    pair
        the two solutions, with their last cycles on common instants
    name
        "tangential_displacement" or "normal_approach", (k,) in a cycle [length]
    reason_for_no_value
        note of the metric where the displacement of the reference does not vary
    """
    reference_amplitude = float(np.ptp(getattr(pair.reference_cycle, name))) / 2
    result_amplitude = float(np.ptp(getattr(pair.result_cycle, name))) / 2
    if not math.isfinite(reference_amplitude + result_amplitude):
        return _metric_without_value("a solution states none")
    typical_displacement = pair.scales.displacement
    if reference_amplitude <= _NEGLIGIBLE_SHARE * typical_displacement:
        return _metric_without_value(reason_for_no_value)
    return _difference_of_amounts(
        reference_amplitude, result_amplitude, typical_displacement, note=_NOTE_ON_COMPLIANCES
    )


def dissipation_without_steps(pair: Pair) -> MetricValue:
    """Friction work W, (result − reference)/reference, both for loads that run straight from one
    instant to the next: the error of the load increments drops out.
    """
    reference_on_polygon = pair.polygon_reference or pair.reference
    result_on_polygon = solution_on_straight_steps(pair.result)
    return _difference_of_amounts(
        reference_on_polygon.dissipation, result_on_polygon.dissipation, pair.scales.dissipation
    )


def dissipation_of_steps(pair: Pair) -> MetricValue:
    """The error that the load increments of the result make in the friction work W, as half-plane
    theory shows it: (W on the polygon of the increments − W on the smooth path)/(W on the smooth
    path).

    Finite elements correct their own W for the curve of the path within an increment. W on the
    polygon is multiplied by the same factor, so that only the rest of the error is left. Where the
    reference dissipates nothing the difference is over A f^2 P_ref^2 (`pair.scales.dissipation`).

    # notation: A = 2/E* compliance of the materials (E* contact modulus), f friction coefficient,
    # P_ref reference load
    """
    # theory with straight loads between the instants; on the smooth path where there is none
    reference_on_polygon = pair.polygon_reference or pair.reference
    work_on_polygon = solution_on_straight_steps(pair.result).dissipation
    factor_for_curve = pair.result.dissipation / work_on_polygon if work_on_polygon else 1.0
    return _difference_of_amounts(
        pair.reference.dissipation,
        reference_on_polygon.dissipation * factor_for_curve,
        pair.scales.dissipation,
    )


def hysteresis(pair: Pair) -> MetricValue:
    """Closed integral of Q dU over the cycle, the work of the tangential load Q on the displacement
    U: (result − reference)/reference; no value where the load path is not periodic.
    """
    if not pair.is_periodic:
        return _metric_without_value(_REASON_NO_LOOP)
    return _difference_of_amounts(
        loop_work(pair.reference_cycle), loop_work(pair.result_cycle), pair.scales.dissipation
    )


def bulk_term(pair: Pair) -> MetricValue:
    """Work of the bulk stress per cycle, result − reference over the friction work W of the
    reference.

    The work is −(closed integral of m_q d(eps)), m_q the moment of the shear and eps the bulk
    strain. Where the reference does no friction work (below 1e-12 of A f^2 P_ref^2,
    `pair.scales.dissipation`) the difference is over A f^2 P_ref^2, and marked `absolute`. No value
    where the load path does not repeat, or where a solution states no m_q (`shear_moment`).

    # notation: A = 2/E* compliance of the materials (E* contact modulus), f friction coefficient,
    # P_ref reference load
    """
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    if not pair.is_periodic:
        # _REASON_NO_LOOP: the text of the note, on a path that is not periodic
        return _metric_without_value(_REASON_NO_LOOP)
    for cycle, solution in ((reference_cycle, pair.reference), (result_cycle, pair.result)):
        if cycle.shear_moment is None:
            return _metric_without_value(
                f"{engine_in_words(solution.engine)} states no moment of its shear"
            )
    materials = pair.result.scene.material
    difference = bulk_work(result_cycle, materials) - bulk_work(reference_cycle, materials)
    friction_work = pair.reference.dissipation
    scale = pair.scales.dissipation
    is_absolute = abs(friction_work) <= _NEGLIGIBLE_SHARE_OF_WORK * scale
    denominator = scale if is_absolute else friction_work
    return MetricValue(value=difference / denominator, absolute=is_absolute)


def drift(pair: Pair) -> MetricValue:
    """Change of the friction work W from the cycle before to the last cycle, over W: result −
    reference. The note states both changes. No value where the change of a solution is not known
    (NaN).
    """
    # relative changes from the cycle before to the last cycle; 0 in a steady state
    reference_change = pair.reference.dissipation_drift
    result_change = pair.result.dissipation_drift
    sentences = []
    for solution, change in ((pair.reference, reference_change), (pair.result, result_change)):
        if math.isnan(change):
            sentences.append(f"{engine_in_words(solution.engine)}: not known")
        elif change:
            # `minus`: with a real minus sign
            change_in_words = minus(f"{change:+.1e}")
            sentences.append(
                f"{engine_in_words(solution.engine)}: {change_in_words} in its last cycle"
            )
    note = "; ".join(sentences)
    if math.isnan(reference_change) or math.isnan(result_change):
        return _metric_without_value(note)
    return MetricValue(value=result_change - reference_change, note=note)


def dissipation_density(pair: Pair) -> MetricValue:
    """Friction work per area of the cycle, w(x) − w_ref(x) over the largest w_ref, at the worst
    point.

    Over A f^2 P_ref^2/a_ref (`pair.scales.dissipation_density`) and marked `absolute` where the
    reference does no friction work anywhere: no more than 1e-12 of that. A NaN counts as work.

    # notation: A = 2/E* compliance of the materials (E* contact modulus), f friction coefficient,
    # P_ref reference load, a_ref half-width at it
    """
    # last cycles: `dissipation_density` is w at the common points, (n,)
    reference_cycle = pair.reference_cycle
    result_cycle = pair.result_cycle
    reference_density = reference_cycle.dissipation_density
    largest_reference = np.max(np.abs(reference_density))
    is_absolute = bool(
        largest_reference <= _NEGLIGIBLE_SHARE_OF_WORK * pair.scales.dissipation_density
    )
    scale = pair.scales.dissipation_density if is_absolute else largest_reference
    difference = (result_cycle.dissipation_density - reference_density) / scale
    is_considered = np.ones(len(difference), bool)  # every point
    value, worst_x = _worst_value_and_place(difference, is_considered, result_cycle.x)
    place = None if worst_x is None else worst_x / pair.scales.half_width
    return MetricValue(value=value, absolute=is_absolute, place=place)


def energy_balance(pair: Pair) -> MetricValue:
    """Largest residual of the energy balance that the result states in its record, work of the
    loads minus stored energy and dissipation; no reference is needed. No value where the record
    states none.
    """
    # (n_instants,) over the largest work of the loads
    balance = pair.result.record.certificates.get("energy_balance")
    if balance is None:
        return _metric_without_value("the result records none")
    series = np.asarray(balance, dtype=float)[pair.result.last_cycle]
    return _value_at_worst_instant(pair, series, np.ones(len(series), bool))
