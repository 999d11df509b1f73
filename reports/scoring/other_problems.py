"""Tractions that belong to a problem the suite does not solve, where the rows of a result show it.

Each problem has a signature of its own in the rows: a closed form of a textbook, its sizes fitted
at each instant, or a feature that no elastic contact of smooth faces has. It is judged as a cause
is: it must leave less than a third of the difference, not by chance, and so much less than a cause
of the suite that the file tells both apart.

# notation: p pressure, q shear, f friction coefficient, P and Q loads, a and c half-widths of
contact and stick, xi = x/a, p0 largest pressure of an ellipse
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy, Mask, Residual, Tractions
from reports.scoring.fits import (
    LARGEST_PROBABILITY_BY_CHANCE,
    LARGEST_SHARE_LEFT,
    Fit,
    leaves_clearly_more,
    probability_of_gain,
    share_of_norm,
)
from reports.scoring.traces import WORDS, Diagnosis
from scenes import SLIP_FORWARD, SLIP_REVERSE, Hertz
from scenes.array_types import Array
from semi_analytic.profiles import contact_of

# Number of half-widths that are tried beyond the outermost point with a pressure: a singular
# traction ends within a spacing of it.
_N_HALF_WIDTHS = 60
# Least tension, over the largest pressure, that extrapolation beyond an edge does not make; and
# fewest points in tension on each side: a mesh makes one.
_LEAST_TENSION_SHARE = 0.05
_FEWEST_IN_TENSION = 2
# Pressure, over the largest of an instant, below which a point is open; above which it is well
# inside the contact of the reference.
_LARGEST_OPEN_PRESSURE_SHARE = 1e-3
_LEAST_INNER_PRESSURE_SHARE = 0.2
# Fewest points of a gap between two zones of contact, fewest gaps at an instant, and least share of
# P that the reference carries over them: one point may be a corner node, one gap a hole in the
# table.
_FEWEST_IN_GAP = 2
_FEWEST_GAPS = 2
_LEAST_SHARE_OVER_GAPS = 0.1
# Difference of the sum of the pressures of another problem from P, over P, at most.
_LARGEST_IMBALANCE = 0.1
# Fewest points of an instant on which a pressure is at its limit; elastic theory there exceeds the
# limit by this factor.
_FEWEST_ON_LIMIT = 5
_LEAST_RATIO_TO_LIMIT = 1.1
# Loads over P of the elastic pressure that a limit is put on: a contact with a limit is wider.
_LOAD_RATIOS = np.linspace(1.0, 2.5, 31)
# Least constant, over f p_ref, of a law of friction that is no coefficient; fewest points in slip
# that show it; what the law may leave (rms) of the shear that is not proportional to p.
_LEAST_CONSTANT_SHARE = 0.05
_FEWEST_IN_SLIP = 8
_LARGEST_SHARE_LEFT_BY_LAW = 0.1
# p0/a of a sphere, 2 E*/(pi R), over that of a cylinder, E*/(2 R).
_SPHERE_OVER_CYLINDER = 4 / np.pi
# Relative difference of P, and of the sum of the pressures, at two instants with the same load; and
# least difference of their pressures, over the pressure, where the bodies are not elastic.
_LARGEST_DIFFERENCE_OF_SAME_LOAD = 0.01
_LEAST_PRESSURE_CHANGE = 0.05
# Share of the squares of that difference that may be noise, and fewest values that show it: of pure
# noise all is, but for 0.22 of it where 20 values and their mirror images are known.
_LARGEST_SHARE_OF_NOISE = 0.2
_FEWEST_VALUES_OF_DIFFERENCE = 40


@dataclass(frozen=True, eq=False)
class ProblemFit:
    """Tractions that a result would have if it solved another problem than the scene's.

    Attributes
    ----------
    predicted_tractions
        (2, k, n) pressure and shear of the problem, its sizes fitted to the result; those of the
        reference where the problem says nothing
    tractions_to_beat
        (2, k, n) those that it must do better than: the reference's, or those of the best cause
        that it could be taken for
    n_sizes
        number of sizes that were fitted beyond those of `tractions_to_beat`
    judged_points
        (k, n) points on which it is judged
    sentence_values
        values for the problem's sentence in templates/faults.toml
    evidence
        measured values, in words
    """

    predicted_tractions: Tractions
    tractions_to_beat: Tractions
    n_sizes: int
    judged_points: Mask
    sentence_values: dict[str, float | str] = field(default_factory=dict)
    evidence: tuple[str, ...] = ()


@dataclass(frozen=True)
class OtherProblem:
    """A problem that the suite does not solve.

    Attributes
    ----------
    key
        of its sentence in templates/faults.toml
    component
        0 where the pressure shows it, 1 where the shear does
    fit
        gives the tractions of the problem that are nearest to a result; None where the result does
        not have its signature
    """

    key: str
    component: int
    fit: Callable[[Discrepancy], ProblemFit | None]

    def residual(
        self, discrepancy: Discrepancy, tractions: Tractions, problem_fit: ProblemFit
    ) -> Residual:
        """Result minus `tractions`, on the points on which the problem is judged."""
        residual_everywhere = discrepancy.residual(tractions, self.component)
        return replace(
            residual_everywhere, is_in_contact=problem_fit.judged_points & (discrepancy.weight > 0)
        )


# ------------------------------------------------------------------------- closed forms of pressure
def _points_in_contact(discrepancy: Discrepancy, pressure: Array) -> Mask:
    """Whether each of the (k, n) points is in contact in the result, in the reference, or with the
    `pressure` (k, n) of a problem. `discrepancy` holds the tractions of result and reference.
    """
    predicted_tractions = _tractions_with(discrepancy, PRESSURE, pressure)
    return discrepancy.mask_in_contact(predicted_tractions) | discrepancy.mask_in_contact(
        discrepancy.reference_tractions
    )


def _tractions_with(discrepancy: Discrepancy, component: int, traction: Array) -> Tractions:
    """The tractions of the reference, (2, k, n), with another pressure (`component` 0) or shear
    (1): `traction`, (k, n).
    """
    tractions = discrepancy.reference_tractions.copy()
    tractions[component] = traction
    return tractions


def _pressed_points(discrepancy: Discrepancy) -> Mask:
    """Whether each of the (k, n) points has a pressure or a tension in the result."""
    pressure_size = np.abs(discrepancy.result_tractions[PRESSURE])
    largest_size = pressure_size.max(axis=1, keepdims=True)
    return np.asarray(pressure_size > _LARGEST_OPEN_PRESSURE_SHARE * largest_size)


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A sum of functions of xi, fitted to the pressure of each instant.

    Attributes
    ----------
    pressure
        (k, n) [stress]
    factors
        (k, number of functions) [stress]
    half_widths
        (k,) [length]
    """

    pressure: Array
    factors: Array
    half_widths: Array


def _fitted_closed_form(
    discrepancy: Discrepancy, functions: Callable[[Array], Array]
) -> ClosedForm | None:
    """Fit a sum of given functions of xi = (x − centre)/half-width to the result's pressure at each
    instant, with factors that are all positive: the fitted pressure (k, n), the factors, and the
    half-widths (k,).

    None where a factor is not positive, or where fewer than three points carry pressure.

    Parameters
    ----------
    discrepancy
        tractions of result and reference at k instants and n points
    functions
        xi (m,), |xi| < 1 -> (m, number of functions)
    """
    fits = []
    # pressed points (k, n): with a pressure or a tension; weight (k, n) in the sum of squares
    for pressure, is_pressed, weights in zip(
        discrepancy.result_tractions[PRESSURE],
        _pressed_points(discrepancy),
        discrepancy.weight,
        strict=True,
    ):
        if is_pressed.sum() < 3:
            return None
        form_at_instant = _closed_form_at_instant(
            discrepancy.x, pressure, is_pressed, weights, functions
        )
        if np.any(form_at_instant.factors <= 0):
            return None
        fits.append(form_at_instant)
    pressures, factors, half_widths = zip(*fits, strict=True)
    return ClosedForm(np.array(pressures), np.array(factors), np.array(half_widths))


class _FormAtInstant(NamedTuple):
    """A sum of functions of xi = (x - centre)/half-width, fitted to the pressure of one instant:
    its values (n,) [stress], the factor of each function [stress], and the half-width [length].
    """

    pressure: Array
    factors: Array
    half_width: float


def _closed_form_at_instant(
    x: Array,
    pressure: Array,
    is_pressed: Mask,
    weights: Array,
    functions: Callable[[Array], Array],
) -> _FormAtInstant:
    """Fit a sum of given functions to the pressure of one instant; return the fitted pressure (n,),
    the factor of each function, and the half-width of the contact.

    The functions are of xi = (x - centre)/half-width. Of 60 half-widths the one is taken whose sum
    of squares is least; for each the factors follow by linear least squares.

    Parameters
    ----------
    x, pressure
        (n,) points, and the pressure at them
    is_pressed
        (n,) whether a point has a pressure or a tension
    weights
        (n,) of the points in the sum of squares
    functions
        xi (m,), |xi| < 1 -> (m, number of functions)
    """
    centre, half_widths = _centre_and_half_widths(x, is_pressed)
    root_of_weights = np.sqrt(weights)
    n_functions = functions(np.zeros(1)).shape[1]
    least_sum_of_squares = np.inf
    for half_width in half_widths.tolist():
        xi = (x - centre) / half_width
        is_inside = np.abs(xi) < 1
        function_values = np.zeros((len(x), n_functions))
        function_values[is_inside] = functions(xi[is_inside])
        solution = np.linalg.lstsq(
            root_of_weights[:, None] * function_values, root_of_weights * pressure, rcond=None
        )
        factors: Array = np.asarray(solution[0], dtype=np.float64)
        fitted_pressure: Array = function_values @ factors
        sum_of_squares = float(np.sum(weights * (pressure - fitted_pressure) ** 2))
        if sum_of_squares < least_sum_of_squares:
            least_sum_of_squares = sum_of_squares
            best_form = _FormAtInstant(fitted_pressure, factors, half_width)
    return best_form


def _centre_and_half_widths(x: Array, is_pressed: Mask) -> tuple[float, Array]:
    """Centre of a contact, and 60 half-widths to try for it [length]. The centre is the middle of
    the outermost points with a pressure. The half-widths go from these points to a spacing of the
    points beyond them: a singular pressure may end there.

    Parameters
    ----------
    x
        (n,) the points, ascending
    is_pressed
        (n,) whether a point has a pressure or a tension
    """
    pressed_points = np.flatnonzero(is_pressed)
    first_point, last_point = pressed_points[0], pressed_points[-1]
    centre = (x[first_point] + x[last_point]) / 2
    half_distance = (x[last_point] - x[first_point]) / 2
    spacing_before = x[first_point] - x[max(first_point - 1, 0)]
    spacing_after = x[min(last_point + 1, len(x) - 1)] - x[last_point]
    spacing = max(spacing_before, spacing_after, np.diff(x).min())
    shares_of_spacing = (np.arange(_N_HALF_WIDTHS) + 0.5) / _N_HALF_WIDTHS
    return float(centre), half_distance + shares_of_spacing * spacing


def _fit_of_adhesion(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of a strip with adhesion, p = p0 sqrt(1 - xi^2) - p1/sqrt(1 - xi^2), to the result's
    pressure (Johnson 1985, 5.5); xi goes from -1 to 1 across the contact. Returns the tractions
    (2, k, n) with this pressure, those of the reference that they must do better than, and the
    number of fitted sizes.

    None unless two points on each side of the peak are in tension at every instant, by up to 5 % of
    the largest pressure or more. None too where p0 or p1 would not be positive. `discrepancy` holds
    the tractions of result and reference.

    # notation: p pressure, p0 and p1 fitted factors
    """
    result_pressure = discrepancy.result_tractions[PRESSURE]
    largest_pressure = result_pressure.max(axis=1, keepdims=True)
    # beyond a thousandth of the largest pressure of the instant
    is_in_tension = result_pressure < -_LARGEST_OPEN_PRESSURE_SHARE * largest_pressure
    largest_tension = float(np.max(-result_pressure / np.maximum(largest_pressure, 1e-300)))
    # 5 % of the largest pressure, which no extrapolation makes; two points on each side
    if largest_tension < _LEAST_TENSION_SHARE:
        return None
    for pressure_of_instant, is_in_tension_at_instant in zip(
        result_pressure, is_in_tension, strict=True
    ):
        peak_index = int(np.argmax(pressure_of_instant))
        n_points_on_left = is_in_tension_at_instant[:peak_index].sum()
        n_points_on_right = is_in_tension_at_instant[peak_index:].sum()
        if min(n_points_on_left, n_points_on_right) < _FEWEST_IN_TENSION:
            return None

    def pressure_terms(xi: Array) -> Array:
        """The two terms of the pressure at xi (m,), (m, 2): of compression and of adhesion."""
        root = np.sqrt(1 - xi**2)
        return np.column_stack([root, -1 / root])

    # pressure (k, n), factors and half-widths that fit best
    closed_form = _fitted_closed_form(discrepancy, pressure_terms)
    if closed_form is None:
        return None
    evidence = f"{int(is_in_tension.sum())} points are in tension, at both edges of contact"
    return ProblemFit(
        # shear as in the reference; three sizes of each instant: p0, p1, half-width
        predicted_tractions=_tractions_with(discrepancy, PRESSURE, closed_form.pressure),
        tractions_to_beat=discrepancy.reference_tractions,
        n_sizes=3 * len(result_pressure),
        # in contact in the result, in the reference or with this pressure
        judged_points=_points_in_contact(discrepancy, closed_form.pressure),
        sentence_values={"tension": largest_tension},
        evidence=(evidence,),
    )


def _fit_of_sharp_punch(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of a flat punch with sharp corners, p = P/(pi a sqrt(1 - xi^2)), to a result's pressure
    (Johnson 1985, 2.8); xi = (x - centre)/a. Returns the tractions (2, k, n) with this pressure,
    those of the reference that they must do better than, and the number of fitted sizes.

    None where the width of the contact changes, for a punch keeps its width, and where no load
    above 0 fits. `discrepancy` holds the tractions of result and reference.

    # notation: P normal load, p pressure
    """
    # pressure (k, n) and half-widths (k,) that fit best
    closed_form = _fitted_closed_form(discrepancy, lambda xi: (1 / np.sqrt(1 - xi**2))[:, None])
    if closed_form is None:
        return None
    largest_half_width = float(closed_form.half_widths.max())
    least_half_width = float(closed_form.half_widths.min())
    largest_spacing = float(np.diff(discrepancy.x).max())
    if least_half_width < largest_half_width - 2 * largest_spacing:
        return None
    return ProblemFit(
        # shear as in the reference; sizes: P and the half-width of each instant
        predicted_tractions=_tractions_with(discrepancy, PRESSURE, closed_form.pressure),
        tractions_to_beat=discrepancy.reference_tractions,
        n_sizes=2 * len(closed_form.half_widths),
        # in contact in the result, in the reference or with this pressure
        judged_points=_points_in_contact(discrepancy, closed_form.pressure),
        sentence_values={"half_width": largest_half_width},
    )


def _fit_of_sphere(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit the pressure of a sphere, in place of the scene's cylinder, to a result's pressure: does
    the result solve the axisymmetric problem? Returns the tractions (2, k, n) with this pressure,
    those of the reference that they must do better than, and the number of fitted sizes.

    Sphere: p = p0 sqrt(1 - xi^2), p0/a = 2 E*/(pi R), and P = 2 pi a^2 p0/3 is a force (Johnson
    1985, 4.2). A cylinder has p0/a = E*/(2 R). xi = x/a, with the half-width a that fits best at
    each instant. None where the profile is no parabola, and where no half-widths can be fitted.

    # notation: a_ref half-width of contact of the reference, E* composite modulus, P normal load, p
    #           pressure, p0 its largest value, p_ref scale of pressure, R radius
    """
    profile = discrepancy.scene.profile
    if not isinstance(profile, Hertz):
        return None
    # half-widths (k,) that fit best
    closed_form = _fitted_closed_form(discrepancy, lambda xi: np.sqrt(1 - xi**2)[:, None])
    if closed_form is None:
        return None
    scales = discrepancy.comparison.scales
    # scales: p_ref and a_ref of the cylinder; their ratio is E*/(2 R)
    # p0/a of a sphere is 4/pi times that of a cylinder
    pressure_over_half_width = _SPHERE_OVER_CYLINDER * scales.pressure / scales.half_width
    xi = discrepancy.x / closed_form.half_widths[:, None]
    sphere_pressure = (
        pressure_over_half_width
        * closed_form.half_widths[:, None]
        * np.sqrt(np.maximum(1 - xi**2, 0.0))
    )
    largest_force = float(
        np.max(2 / 3 * np.pi * closed_form.half_widths**3 * pressure_over_half_width)
    )
    return ProblemFit(
        # shear as in the reference; one size, the half-width, for each instant
        predicted_tractions=_tractions_with(discrepancy, PRESSURE, sphere_pressure),
        tractions_to_beat=discrepancy.reference_tractions,
        n_sizes=len(sphere_pressure),
        # in contact in the result, in the reference or with this pressure
        judged_points=_points_in_contact(discrepancy, sphere_pressure),
        sentence_values={"force": largest_force},
    )


def _fit_of_limited_pressure(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of a pressure that is cut off at a limit to a result's pressure: p = min(limit, elastic
    pressure of a larger load), with the same limit at all instants, as plastic flow or wear
    flattens the middle. Returns the tractions (2, k, n) with this pressure, those of the reference
    that they must do better than, and the number of fitted sizes.

    None where no instant has five points on the limit, and where the contact is not symmetric.
    `discrepancy` holds the tractions of result and reference.

    # notation: p pressure
    """
    if discrepancy.unsymmetric:
        return None
    result_pressure = discrepancy.result_tractions[PRESSURE]
    limit = float(np.median(result_pressure[result_pressure > 0.9 * result_pressure.max()]))
    limited_pressure, most_points_on_limit = _elastic_pressure_below_limit(discrepancy, limit)
    if most_points_on_limit < _FEWEST_ON_LIMIT:
        return None
    is_above_limit = discrepancy.reference_tractions[PRESSURE] > limit
    return ProblemFit(
        predicted_tractions=_tractions_with(discrepancy, PRESSURE, limited_pressure),
        tractions_to_beat=discrepancy.reference_tractions,
        # a load at each instant, and the limit
        n_sizes=len(limited_pressure) + 1,
        # in contact in the result, in the reference or with this pressure
        judged_points=_points_in_contact(discrepancy, limited_pressure),
        sentence_values={"limit": limit / discrepancy.comparison.scales.pressure},
        evidence=(
            f"{most_points_on_limit} points of one instant have {limit:.4g}, and no point has more"
            f" than {result_pressure.max() / limit:.3g} times that, where the reference exceeds it"
            f" at {int(is_above_limit.sum())} points",
        ),
    )


def _elastic_pressure_below_limit(
    discrepancy: Discrepancy, pressure_limit: float
) -> tuple[Array, int]:
    """Pressure (k, n) of elastic half-planes of the scene's profile, cut off at a `pressure_limit`
    [stress]. At each of the k instants the load is that, of 1 to 2.5 times P, which fits the
    result's pressure best. With it comes the largest number of points, at any instant, where the
    elastic pressure exceeds the limit by a tenth.

    # notation: P normal load
    """
    contact = contact_of(discrepancy.scene.profile, discrepancy.scene.material)
    limited_pressures = []
    most_points_on_limit = 0
    for result_pressure, normal_load, weights in zip(
        discrepancy.result_tractions[PRESSURE],
        discrepancy.normal_load,
        discrepancy.weight,
        strict=True,
    ):
        elastic_pressures = contact.pressure(discrepancy.x, normal_load * _LOAD_RATIOS[:, None])
        trial_pressures = np.minimum(elastic_pressures, pressure_limit)
        sums_of_squares = np.sum(weights * (result_pressure - trial_pressures) ** 2, axis=1)
        best_trial = int(np.argmin(sums_of_squares))
        limited_pressures.append(trial_pressures[best_trial])
        is_on_limit = elastic_pressures[best_trial] > _LEAST_RATIO_TO_LIMIT * pressure_limit
        most_points_on_limit = max(most_points_on_limit, int(np.sum(is_on_limit)))
    return np.array(limited_pressures), most_points_on_limit


# ------------------------------------------------------------------------------- features of rows
def _fit_of_gaps(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of rough or wavy faces, which touch in several zones, to a result's pressure. A gap is a
    row of points without pressure between two zones, inside the contact of the reference. There the
    fit has no pressure, elsewhere that of the reference. Returns the tractions (2, k, n) with such
    gaps, those of the reference that they must do better than, and the points in gaps.

    None where gaps are few or short, or the reference carries less than a tenth of P over them.
    None too where values are only missing from a table: the sum of the pressures then is too small.
    `discrepancy` holds the tractions of result and reference.

    # notation: P normal load
    """
    reference_pressure = discrepancy.reference_tractions[PRESSURE]
    is_in_gap = _points_in_gaps(discrepancy)
    # number of points of each gap, over all instants
    point_counts = [
        point_count
        for is_in_gap_at_instant in is_in_gap
        for point_count in _run_lengths(is_in_gap_at_instant)
    ]
    # of two points and more; two at an instant at least
    n_long_gaps = sum(point_count >= _FEWEST_IN_GAP for point_count in point_counts)
    share_over_gaps = _load_shares_over(discrepancy, is_in_gap)
    least_share = float(share_over_gaps[discrepancy.is_loaded].min())
    has_few_gaps = n_long_gaps < _FEWEST_GAPS * len(is_in_gap)
    if has_few_gaps or least_share < _LEAST_SHARE_OVER_GAPS:
        return None
    # integral of the pressure over P: it differs from 1 by more than a tenth
    if abs(discrepancy.resultant_ratio - 1) > _LARGEST_IMBALANCE:
        return None
    # judged on the gaps alone: the problem says that they are open, and nothing of the zones
    return ProblemFit(
        # the reference's tractions, without pressure in the gaps
        predicted_tractions=_tractions_with(
            discrepancy, PRESSURE, np.where(is_in_gap, 0.0, reference_pressure)
        ),
        tractions_to_beat=discrepancy.reference_tractions,
        n_sizes=1,
        judged_points=is_in_gap,
        sentence_values={"gaps": n_long_gaps / len(is_in_gap)},
        evidence=(
            f"over the gaps the reference carries {float(share_over_gaps.max()):.0%} of P; the sum"
            f" of the pressures is {discrepancy.resultant_ratio:.4g} P all the same",
        ),
    )


def _points_in_gaps(discrepancy: Discrepancy) -> Mask:
    """Whether each of the (k, n) points is open in the result and well inside the contact of the
    reference. Open: below a thousandth of the result's largest pressure at that instant. Well
    inside: above a fifth of the reference's.
    """
    result_pressure = discrepancy.result_tractions[PRESSURE]
    reference_pressure = discrepancy.reference_tractions[PRESSURE]
    largest_of_result = result_pressure.max(axis=1, keepdims=True)
    largest_of_reference = reference_pressure.max(axis=1, keepdims=True)
    is_open = result_pressure <= _LARGEST_OPEN_PRESSURE_SHARE * largest_of_result
    is_well_inside = reference_pressure > _LEAST_INNER_PRESSURE_SHARE * largest_of_reference
    return np.asarray(is_open & is_well_inside)


def _load_shares_over(discrepancy: Discrepancy, is_in_gap: Mask) -> Array:
    """Share of the reference's normal load that its pressure over the gaps carries, (k,) at each
    instant. `is_in_gap` (k, n) states which points lie in gaps.
    """
    reference_pressure = discrepancy.reference_tractions[PRESSURE]
    pressure_over_gaps = np.where(is_in_gap, reference_pressure, 0.0)
    load_over_gaps = np.trapezoid(pressure_over_gaps, discrepancy.x, axis=1)
    load_of_reference = np.trapezoid(reference_pressure, discrepancy.x, axis=1)
    return np.asarray(load_over_gaps / np.maximum(load_of_reference, 1e-300))


def _run_lengths(values: NDArray[np.bool_]) -> list[int]:
    """Lengths of the runs of True in (n,) values.

    >>> _run_lengths(np.array([True, True, False, True]))
    [2, 1]
    """
    ends = np.flatnonzero(np.diff(np.concatenate([[0], values.astype(int), [0]])))
    return [int(end - start) for start, end in ends.reshape(-1, 2)]


def _fit_of_inelastic_bodies(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of bodies that are not elastic to a result's pressure: between like elastic half-planes
    the pressure depends on P alone. Of instants with the same P, by the scene and by the sum of the
    pressures, the two are taken whose pressures differ most.

    The tractions (2, k, n) that are returned have the result's pressure at each of the two
    instants. They must do better than those with both pressures swapped, as elastic bodies would
    have them. None where the pressures differ by less than 5 % or by noise alone, and for an
    unsymmetric scene. The part of the pressure that is odd in x is left out: unlike bodies and
    bodies that tilt make it. `discrepancy` holds the tractions of result and reference.

    # notation: P normal load
    """
    if discrepancy.unsymmetric or len(discrepancy.instants_of_cycle) < 2:
        return None
    result_pressure = discrepancy.result_tractions[PRESSURE]
    even_pressure = (result_pressure + _mirror_image(result_pressure, discrepancy.x)) / 2
    pressure_integrals = np.trapezoid(result_pressure, discrepancy.x, axis=1)
    # root mean square over that of the reference's pressure
    relative_change, first_instant, second_instant = _most_changed_instants(
        discrepancy, even_pressure, pressure_integrals
    )
    is_smooth = _differs_smoothly(discrepancy, even_pressure, first_instant, second_instant)
    if relative_change < _LEAST_PRESSURE_CHANGE or not is_smooth:
        return None
    # what elastic bodies would have: the pressure of either instant at the other one
    swapped_tractions = discrepancy.reference_tractions.copy()
    swapped_tractions[PRESSURE, first_instant] = even_pressure[second_instant]
    swapped_tractions[PRESSURE, second_instant] = even_pressure[first_instant]
    ratio_of_integrals = pressure_integrals[first_instant] / pressure_integrals[second_instant]
    judged_points = np.zeros(result_pressure.shape, dtype=bool)
    judged_points[[first_instant, second_instant]] = True
    return ProblemFit(
        predicted_tractions=_tractions_with(discrepancy, PRESSURE, even_pressure),
        tractions_to_beat=swapped_tractions,
        n_sizes=1,
        judged_points=judged_points,
        sentence_values={
            "share": relative_change,
            "first": float(discrepancy.time[first_instant]),
            "second": float(discrepancy.time[second_instant]),
        },
        evidence=(f"the sums of both pressures agree to {abs(ratio_of_integrals - 1):.1%}",),
    )


def _differs_smoothly(
    discrepancy: Discrepancy, pressure: Array, first_instant: int, second_instant: int
) -> bool:
    """Whether the pressure (k, n) differs between two instants by more than noise: noise makes less
    than a fifth of the mean square of the difference, at 40 points with pressure or more.
    """
    first_pressure = pressure[[first_instant]]
    second_pressure = pressure[[second_instant]]
    # values over the scale of pressure, their weight, and points with pressure
    difference = Residual(
        (first_pressure - second_pressure) / discrepancy.comparison.scales.pressure,
        discrepancy.weight[[first_instant]],
        (first_pressure != 0) | (second_pressure != 0),
    )
    return (
        difference.mean_square_of_noise < _LARGEST_SHARE_OF_NOISE * difference.mean_square
        and difference.n_values >= _FEWEST_VALUES_OF_DIFFERENCE
    )


def _mirror_image(pressure: Array, x: Array) -> Array:
    """Pressure at -x instead of x, (k, n) -> (k, n); 0 where -x lies beyond the points."""
    return np.array(
        [
            np.interp(-x, x, pressure_of_instant, left=0.0, right=0.0)
            for pressure_of_instant in pressure
        ]
    )


def _most_changed_instants(
    discrepancy: Discrepancy, pressure: Array, pressure_integrals: Array
) -> tuple[float, int, int]:
    """The two instants of a result with the same P whose pressures differ most: root mean square
    difference over that of the reference's pressure, and their indices. (0, 0, 0) without such a
    pair. P and the integrals agree to 1 %.

    Parameters
    ----------
    discrepancy
        tractions of result and reference at some instants and all points
    pressure
        (k, n) of the result
    pressure_integrals
        (k,) integrals of the pressure over x, which must agree as P does

    # notation: P normal load
    """
    normal_load = discrepancy.normal_load
    reference_pressure = discrepancy.reference_tractions[PRESSURE]
    reference_rms = np.sqrt(np.mean(reference_pressure**2, axis=1))
    largest_change = (0.0, 0, 0)
    for first_instant, second_instant in itertools.combinations(range(len(pressure)), 2):
        # more than a hundredth of the reference load
        if not (discrepancy.is_loaded[first_instant] and discrepancy.is_loaded[second_instant]):
            continue
        load_difference = abs(normal_load[first_instant] / normal_load[second_instant] - 1)
        integral_difference = abs(
            pressure_integrals[first_instant] / pressure_integrals[second_instant] - 1
        )
        has_same_load = load_difference < _LARGEST_DIFFERENCE_OF_SAME_LOAD
        has_same_integral = integral_difference < _LARGEST_DIFFERENCE_OF_SAME_LOAD
        if not (has_same_load and has_same_integral):
            continue
        rms_difference = float(
            np.sqrt(np.mean((pressure[first_instant] - pressure[second_instant]) ** 2))
        )
        change = rms_difference / float(reference_rms[first_instant])
        largest_change = max(largest_change, (change, first_instant, second_instant))
    return largest_change


# ---------------------------------------------------------------------------------------- the shear
def _fit_of_rolling(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of tractive rolling to a result's shear: the stick zone begins at the leading edge.
    Returns the tractions (2, k, n) with the shear of rolling, those of the reference that they must
    do better than, and the side of the leading edge: the one that fits better.

    None without friction, shear or Q, for an unsymmetric scene, and where all slides at some
    instant.

    # notation: Q tangential load
    """
    friction_coefficient = discrepancy.scene.friction.coefficient
    if discrepancy.unsymmetric or not friction_coefficient or not discrepancy.has_shear:
        return None
    loads = discrepancy.scene.load.path().at(discrepancy.time)
    normal_load = np.asarray(loads[0])[:, None]
    tangential_load = np.asarray(loads[1])[:, None]
    has_no_stick = np.any(normal_load - np.abs(tangential_load) / friction_coefficient <= 0)
    if has_no_stick or np.all(np.abs(tangential_load) < 1e-9 * normal_load):
        return None
    least_sum_of_squares = np.inf
    for side in ("right", "left"):
        shear = _shear_of_rolling(discrepancy, normal_load, tangential_load, side)
        shear_error = discrepancy.result_tractions[SHEAR] - shear
        sum_of_squares = float(np.sum(discrepancy.weight * shear_error**2))
        if sum_of_squares < least_sum_of_squares:
            least_sum_of_squares = sum_of_squares
            best_shear = shear
            leading_side = side
    return ProblemFit(
        predicted_tractions=_tractions_with(discrepancy, SHEAR, best_shear),
        tractions_to_beat=discrepancy.reference_tractions,
        n_sizes=1,  # the side
        # points in contact
        judged_points=discrepancy.mask_in_contact(discrepancy.reference_tractions),
        sentence_values={"side": leading_side},
    )


def _shear_of_rolling(
    discrepancy: Discrepancy, normal_load: Array, tangential_load: Array, leading_side: str
) -> Array:
    """Shear (k, n) of tractive rolling of the scene's bodies, at the n points of a result: q = f
    [p(x, P) - p(x -+ (a - c), P - |Q|/f)] with the sign of Q (Carter 1926; Johnson 1985, 8.3).

    Parameters
    ----------
    discrepancy
        gives the points x (n,) and the scene
    normal_load, tangential_load
        (k, 1) P and Q, |Q| < f P
    leading_side
        side of the leading edge, "right" (larger x) or "left", at which the stick zone begins

    # notation: a and c half-widths of contact and stick, f coefficient of friction, p pressure, q
    #           shear
    """
    # half-plane theory of the profile: half-width and pressure under any load
    contact = contact_of(discrepancy.scene.profile, discrepancy.scene.material)
    friction_coefficient = discrepancy.scene.friction.coefficient
    # load that the stick zone alone would carry
    stick_load = normal_load - np.abs(tangential_load) / friction_coefficient
    # a - c, by which the middle of the stick zone lies from that of the contact
    offsets = contact.half_width(normal_load) - contact.half_width(stick_load)
    pressure = contact.pressure(discrepancy.x, normal_load)
    direction = 1.0 if leading_side == "right" else -1.0
    stick_pressure = np.array(
        [
            contact.pressure(discrepancy.x - direction * offset, load)
            for offset, load in zip(offsets[:, 0], stick_load[:, 0], strict=True)
        ]
    )
    return np.asarray(np.sign(tangential_load) * friction_coefficient * (pressure - stick_pressure))


def _fit_of_friction_law(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of |q| = constant + slope p to a result's shear where the reference slips: a law that is
    no coefficient of friction, such as a shear strength (slope 0) or cohesion (slope f). Returns
    the tractions (2, k, n) with this shear, those with the best coefficient that they must do
    better than, and the points in slip.

    None where such a law leaves more than a tenth of the norm that a coefficient leaves. None too
    where its constant is small or it falls with p, for fewer than eight points in slip, and without
    friction or shear.

    # notation: f coefficient of friction, p pressure, p_ref scale of pressure, q shear
    """
    friction_coefficient = discrepancy.scene.friction.coefficient
    if not friction_coefficient or not discrepancy.has_shear:
        return None
    slip_direction = _slip_direction_of_reference(discrepancy)
    pressure = discrepancy.result_tractions[PRESSURE]
    is_pressed = pressure > _LARGEST_OPEN_PRESSURE_SHARE * pressure.max()
    # weight 0: the result has no number there
    is_in_slip = (slip_direction != 0) & is_pressed & (discrepancy.weight > 0)
    if is_in_slip.sum() < _FEWEST_IN_SLIP:
        return None
    shear_along_slip = slip_direction * discrepancy.result_tractions[SHEAR]
    law = _fitted_friction_law(pressure[is_in_slip], shear_along_slip[is_in_slip])
    shear_scale = discrepancy.comparison.scales.shear
    # a law through the origin is a coefficient of friction; one that falls is no law
    has_small_constant = law.constant < _LEAST_CONSTANT_SHARE * shear_scale
    if has_small_constant or law.slope < -0.1 * friction_coefficient:
        return None

    shear_of_reference = discrepancy.reference_tractions[SHEAR]
    shear_by_law = slip_direction * (law.constant + law.slope * pressure)
    shear_by_coefficient = slip_direction * law.coefficient_alone * pressure
    tractions_by_law = _tractions_with(
        discrepancy, SHEAR, np.where(is_in_slip, shear_by_law, shear_of_reference)
    )
    tractions_by_coefficient = _tractions_with(
        discrepancy, SHEAR, np.where(is_in_slip, shear_by_coefficient, shear_of_reference)
    )
    # result minus the law, over f p_ref, at the points in slip
    residual = replace(discrepancy.residual(tractions_by_law, SHEAR), is_in_contact=is_in_slip)
    if not law.leaves_far_less(residual.mean_square_of_noise * shear_scale**2):
        return None
    return ProblemFit(
        predicted_tractions=tractions_by_law,
        tractions_to_beat=tractions_by_coefficient,
        # the constant, beyond the slope that a coefficient has too
        n_sizes=1,
        judged_points=is_in_slip,
        sentence_values={"constant": law.constant, "slope": law.slope},
        evidence=(
            f"{int(is_in_slip.sum())} points in slip; no coefficient of friction leaves less than"
            f" {law.mean_square_left_by_coefficient**0.5 / shear_scale:.2g} of f p_ref of their"
            f" shear, this law leaves {law.mean_square_left**0.5 / shear_scale:.2g}",
        ),
    )


def _slip_direction_of_reference(discrepancy: Discrepancy) -> Array:
    """Direction of slip at each of the k instants and n points, (k, n): 1 or -1, the sign of the
    reference's shear, where the reference slips; 0 where it sticks or is open.
    """
    states = discrepancy.comparison.reference_cycle.state[discrepancy.instants_of_cycle]
    is_slipping = (states == SLIP_FORWARD) | (states == SLIP_REVERSE)
    return np.where(is_slipping, np.sign(discrepancy.reference_tractions[SHEAR]), 0.0)


class _FrictionLaw(NamedTuple):
    """The law q = constant + slope p, and a coefficient of friction alone, fitted to the shear q
    along slip and the pressure p of points in slip.

    Attributes
    ----------
    constant
        shear at no pressure [stress]
    slope
        rise of the shear over that of the pressure
    coefficient_alone
        coefficient of friction that fits best without a constant
    mean_square_left, mean_square_left_by_coefficient
        mean square of the shear that the law, or this coefficient, leaves [stress^2]
    """

    constant: float
    slope: float
    coefficient_alone: float
    mean_square_left: float
    mean_square_left_by_coefficient: float

    def leaves_far_less(self, mean_square_of_noise: float) -> bool:
        """Whether the law leaves at most a tenth of the shear (root mean square) that the
        coefficient leaves, both but for the noise [stress^2].
        """
        noise_square = min(mean_square_of_noise, self.mean_square_left)
        square_left = self.mean_square_left - noise_square
        square_left_by_coefficient = self.mean_square_left_by_coefficient - noise_square
        return square_left <= _LARGEST_SHARE_LEFT_BY_LAW**2 * square_left_by_coefficient


def _fitted_friction_law(p: Array, q: Array) -> _FrictionLaw:
    """The law q = constant + slope p that fits the pressure p (m,) and the shear along slip q (m,)
    of points in slip best, by least squares; and the coefficient that fits best alone.
    """
    coefficient_alone = float(p @ q / (p @ p))
    (constant, slope), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(p), p]), q, rcond=None)
    return _FrictionLaw(
        constant=float(constant),
        slope=float(slope),
        coefficient_alone=coefficient_alone,
        mean_square_left=float(np.mean((q - constant - slope * p) ** 2)),
        mean_square_left_by_coefficient=float(np.mean((q - coefficient_alone * p) ** 2)),
    )


PROBLEMS = (
    OtherProblem("several_zones", PRESSURE, _fit_of_gaps),
    OtherProblem("adhesion", PRESSURE, _fit_of_adhesion),
    OtherProblem("sharp_punch", PRESSURE, _fit_of_sharp_punch),
    OtherProblem("sphere", PRESSURE, _fit_of_sphere),
    OtherProblem("limit_of_pressure", PRESSURE, _fit_of_limited_pressure),
    OtherProblem("not_elastic", PRESSURE, _fit_of_inelastic_bodies),
    OtherProblem("rolling", SHEAR, _fit_of_rolling),
    OtherProblem("law_of_friction", SHEAR, _fit_of_friction_law),
)


def other_problems(discrepancy: Discrepancy, fit_of_causes: Fit | None) -> Iterator[Diagnosis]:
    """The finding that the tractions of a result belong to a problem which the suite does not
    solve, such as adhesion or rolling. Nothing where no such problem fits, or where the likely
    causes leave little more of the difference.

    Parameters
    ----------
    discrepancy
        tractions of result and reference
    fit_of_causes
        tractions of the reference with the causes that were found to be likely; None where none was
    """
    # Friction follows the pressure: where that is wrong, the shear shows no problem of its own.
    pressure_residual = discrepancy.residual(discrepancy.reference_tractions, PRESSURE)
    is_pressure_right = discrepancy.is_within_tolerance(PRESSURE) or pressure_residual.is_noise
    candidates = []
    # component: the traction that shows the problem
    for problem in PROBLEMS:
        if problem.component == SHEAR and not is_pressure_right:
            continue
        # tractions of the problem, those that they must do better than, the points judged, and
        # words; None where the result does not have the signature of the problem
        problem_fit = problem.fit(discrepancy)
        if problem_fit is None:
            continue
        share_left = _share_left_if_likely(problem, problem_fit, discrepancy, fit_of_causes)
        if share_left is not None:
            candidates.append((share_left, problem, problem_fit))
    if not candidates:
        return
    share_left, problem, problem_fit = min(candidates, key=lambda candidate: candidate[0])
    # WORDS: templates of sentences
    problem_in_words = WORDS["problems"][problem.key].format(**problem_fit.sentence_values)
    sentence = f"{WORDS['other_problem']} {problem_in_words}"
    evidence = (
        *problem_fit.evidence,
        f"tractions of that problem, its sizes fitted, leave {share_left:.1%} of the difference",
    )
    # key and sentence of the finding, evidence, strength from 0 to 1
    yield Diagnosis(problem.key, sentence, evidence, 1 - share_left)


def _share_left_if_likely(
    problem: OtherProblem,
    problem_fit: ProblemFit,
    discrepancy: Discrepancy,
    fit_of_causes: Fit | None,
) -> float | None:
    """Share of the difference that the tractions of another problem leave, 0 to 1; None where the
    result is not likely to solve it. The share is that of the norm on the points of the problem,
    without noise.

    It is likely where less than a third is left, where chance gives this gain with a probability
    below 1e-6, and where the likely causes leave clearly more.

    Parameters
    ----------
    problem, problem_fit
        the problem, and its tractions fitted to the result with those that they must do better than
    discrepancy
        tractions of result and reference
    fit_of_causes
        tractions of the reference with the causes that were found to be likely; None where none was
    """
    residual_after = problem.residual(discrepancy, problem_fit.predicted_tractions, problem_fit)
    # what the scene itself, or the simpler law, leaves on the points of this problem
    residual_before = problem.residual(discrepancy, problem_fit.tractions_to_beat, problem_fit)
    mean_square_of_noise = min(residual_after.mean_square_of_noise, residual_after.mean_square)
    # norm of what the problem leaves over the norm before it, without noise
    share_left = share_of_norm(
        residual_after.mean_square, residual_before.mean_square, mean_square_of_noise
    )
    # probability that noise alone makes this gain, by the F test
    probability = probability_of_gain(
        residual_after.mean_square,
        residual_before.mean_square,
        residual_after.n_values,
        n_parameters=problem_fit.n_sizes,
    )
    if share_left >= LARGEST_SHARE_LEFT or probability >= LARGEST_PROBABILITY_BY_CHANCE:
        return None
    if fit_of_causes is None:
        return share_left
    residual_of_causes = problem.residual(
        discrepancy, fit_of_causes.predicted_tractions, problem_fit
    )
    # four times the mean square, or by more than chance where noise alone is left
    is_better_than_causes = leaves_clearly_more(
        residual_of_causes.mean_square,
        residual_after.mean_square,
        residual_after.n_values,
        is_noise=residual_after.is_noise,
    )
    return share_left if is_better_than_causes else None
