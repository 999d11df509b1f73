"""Tractions that belong to a problem the suite does not solve, where the rows of a result show it.

Each problem has a signature of its own in the rows: a closed form of a textbook, its sizes fitted
at each instant, or a feature that no elastic contact of smooth faces has. It is judged as a cause
is: it must leave less than a third of the difference, not by chance, and so much less than a cause
of the suite that the file tells both apart.

# notation: p pressure, q shear, f friction coefficient, P and Q loads, a and c half-widths of
contact and stick, xi = x/a, p0 largest pressure of an ellipse
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy, Mask, Residual, Tractions
from reports.scoring.fits import CHANCE, MOST_LEFT, Fit, are_apart, gain_by_chance, share_of_norm
from reports.scoring.traces import WORDS, Diagnosis
from scenes import SLIP_FORWARD, SLIP_REVERSE, Hertz
from scenes.array_types import Array
from semi_analytic.profiles import contact_of

# Over the outermost point that carries, the half-widths that are tried: a singular traction ends
# within a spacing of it.
_EDGES_TRIED = 60
# Of the largest pressure, a tension that extrapolation beyond an edge does not make; and points in
# tension on each side, one of which a mesh makes.
_TENSION = 0.05
_FEWEST_IN_TENSION = 2
# Of the largest pressure of an instant, below which a point is open; above which it is well inside
# the contact of the reference.
_OPEN = 1e-3
_WELL_INSIDE = 0.2
# Points of a gap between two zones of contact, gaps, and the share of P that the reference carries
# over them: one point may be a corner node, one gap a hole in the table.
_FEWEST_IN_GAP = 2
_FEWEST_GAPS = 2
_LEAST_OVER_GAPS = 0.1
# Over P, by which the sum of the pressures of another problem may differ from it.
_BALANCED = 0.1
# Points of an instant on which a pressure is at its limit; how far elastic theory exceeds it there.
_FEWEST_ON_LIMIT = 5
_ABOVE_LIMIT = 1.1
# Loads over P of the elastic pressure that a limit is put on: a contact with a limit is wider.
_WIDER = np.linspace(1.0, 2.5, 31)
# Of f p_ref, the constant of a law of friction that is no coefficient; points in slip that show it;
# what the law may leave of the shear that is not proportional to p.
_LEAST_CONSTANT = 0.05
_FEWEST_IN_SLIP = 8
_LEFT_OF_LAW = 0.1
# Slope of the pressure of a sphere over its half-width, over that of a cylinder: p0/a = 2 E*/(pi R)
# and E*/(2 R).
_SPHERE = 4 / np.pi
# Over P and over the pressure, by which two instants of one load may differ; of the pressure, what
# differs between them where the bodies are not elastic.
_SAME_LOAD = 0.01
_OTHER_PRESSURE = 0.05
# Of the square of that difference, what may change from point to point, and values that show it:
# of noise all does, but for 0.22 of it where 20 values and their mirror images are known.
_SMOOTH = 0.2
_FEWEST_SMOOTH = 40


@dataclass(frozen=True, eq=False)
class ProblemFit:
    """What a problem makes of a result.

    Attributes
    ----------
    predicted
        tractions of the problem, its sizes fitted; those of the reference where it says nothing
    tractions_to_beat
        those that it must do better than: the reference's, or those of the best cause that it
        could be taken for
    parameters
        sizes that were fitted beyond those of `tractions_to_beat`
    judged_points
        (k, n) points on which it is judged
    figures
        numbers of its sentence
    evidence
        measured values, in words
    """

    predicted: Tractions
    tractions_to_beat: Tractions
    parameters: int
    judged_points: Mask
    figures: dict[str, float | str] = field(default_factory=dict)
    evidence: tuple[str, ...] = ()


@dataclass(frozen=True)
class OtherProblem:
    """A problem that the suite does not solve.

    Attributes
    ----------
    key
        of its sentence in templates/faults.toml
    channel
        0 where the pressure shows it, 1 where the shear does
    fit
        what it makes of a result; None where the result does not have its signature
    """

    key: str
    channel: int
    fit: Callable[[Discrepancy], ProblemFit | None]

    def residual(
        self, discrepancy: Discrepancy, tractions: Tractions, problem_fit: ProblemFit
    ) -> Residual:
        """What tractions leave of the result's, on the points on which the problem is judged."""
        residual_everywhere = discrepancy.residual(tractions, self.channel)
        return replace(
            residual_everywhere, is_inside=problem_fit.judged_points & (discrepancy.weight > 0)
        )


# ------------------------------------------------------------------------- closed forms of pressure
def _in_contact(discrepancy: Discrepancy, pressure: Array) -> Mask:
    """(k, n) points that carry in the result, in the reference or in a problem."""
    predicted = _with(discrepancy, PRESSURE, pressure)
    return discrepancy.in_contact(predicted) | discrepancy.in_contact(
        discrepancy.reference_tractions
    )


def _with(discrepancy: Discrepancy, channel: int, traction: Array) -> Tractions:
    """The tractions expected with another pressure or shear."""
    tractions = discrepancy.reference_tractions.copy()
    tractions[channel] = traction
    return tractions


def _carrying(discrepancy: Discrepancy) -> Mask:
    """(k, n) points with a pressure or a tension in the result."""
    size = np.abs(discrepancy.result_tractions[PRESSURE])
    return np.asarray(size > _OPEN * size.max(axis=1, keepdims=True))


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


def _closed_form(
    discrepancy: Discrepancy, functions: Callable[[Array], Array]
) -> ClosedForm | None:
    """Fit a sum of given functions of xi = (x − centre)/half-width to the result's pressure at each
    instant: the fitted pressure, factors and half-widths.

    None where a factor is not positive, or fewer than three points carry pressure.

    Parameters
    ----------
    discrepancy
        tractions of result and reference at some instants and all points
    functions
        xi (m,), |xi| < 1 -> (m, number of functions)
    """
    fits = []
    for pressure, carries, weight in zip(
        discrepancy.result_tractions[PRESSURE],
        _carrying(discrepancy),
        discrepancy.weight,
        strict=True,
    ):
        if carries.sum() < 3:
            return None
        fit_of_instant = _fitted_row(discrepancy.x, pressure, carries, weight, functions)
        if np.any(fit_of_instant[1] <= 0):
            return None
        fits.append(fit_of_instant)
    pressures, factors, half_widths = zip(*fits, strict=True)
    return ClosedForm(np.array(pressures), np.array(factors), np.array(half_widths))


def _fitted_row(
    x: Array, pressure: Array, carries: Mask, weight: Array, functions: Callable[[Array], Array]
) -> tuple[Array, Array, float]:
    """Fit a sum of given functions to the pressure of one instant; return the fitted pressure (n,),
    the factor of each function, and the half-width of the contact.

    The functions are of xi = (x - centre)/half-width. The centre is the middle of the points that
    carry pressure; half-widths are tried from the outermost of these to a spacing beyond it, and
    for each the factors follow by linear least squares.

    Parameters
    ----------
    carries
        (n,) which points carry pressure
    weight
        (n,) weights of the points
    """
    carrying_points = np.flatnonzero(carries)
    first_point, last_point = carrying_points[0], carrying_points[-1]
    centre = (x[first_point] + x[last_point]) / 2
    half_distance = (x[last_point] - x[first_point]) / 2
    spacing_before = x[first_point] - x[max(first_point - 1, 0)]
    spacing_after = x[min(last_point + 1, len(x) - 1)] - x[last_point]
    spacing = max(spacing_before, spacing_after, np.diff(x).min())
    root_of_weight = np.sqrt(weight)
    least_square = np.inf
    for share in (np.arange(_EDGES_TRIED) + 0.5) / _EDGES_TRIED:
        half_width = float(half_distance + share * spacing)
        xi = (x - centre) / half_width
        is_inside = np.abs(xi) < 1
        function_values = np.zeros((len(x), functions(np.zeros(1)).shape[1]))
        function_values[is_inside] = functions(xi[is_inside])
        solution = np.linalg.lstsq(
            root_of_weight[:, None] * function_values, root_of_weight * pressure, rcond=None
        )
        factors: Array = np.asarray(solution[0], dtype=np.float64)
        fitted_pressure: Array = function_values @ factors
        square = float(np.sum(weight * (pressure - fitted_pressure) ** 2))
        if square < least_square:
            least_square = square
            best_fit = fitted_pressure, factors, half_width
    return best_fit


def _adhesion(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of a strip with adhesion, p = p0 sqrt(1 - xi^2) - p1/sqrt(1 - xi^2), to the result's
    pressure (Johnson 1985, 5.5); xi goes from -1 to 1 across the contact. None where the result has
    no tension next to both edges. `discrepancy` holds the tractions of result and reference.
    """
    pressure = discrepancy.result_tractions[PRESSURE]
    largest_pressure = pressure.max(axis=1, keepdims=True)
    points_in_tension = pressure < -_OPEN * largest_pressure
    largest_tension = float(np.max(-pressure / np.maximum(largest_pressure, 1e-300)))
    if largest_tension < _TENSION:
        return None
    for pressure_of_instant, is_in_tension in zip(pressure, points_in_tension, strict=True):
        peak_index = int(np.argmax(pressure_of_instant))
        if (
            min(is_in_tension[:peak_index].sum(), is_in_tension[peak_index:].sum())
            < _FEWEST_IN_TENSION
        ):
            return None

    def strip(xi: Array) -> Array:
        """The two parts of the pressure at xi (m,), (m, 2): without and with tension."""
        root = np.sqrt(1 - xi**2)
        return np.column_stack([root, -1 / root])

    closed_form = _closed_form(discrepancy, strip)
    if closed_form is None:
        return None
    evidence = f"{int(points_in_tension.sum())} points are in tension, at both edges of contact"
    return ProblemFit(
        _with(discrepancy, PRESSURE, closed_form.pressure),
        discrepancy.reference_tractions,
        3 * len(pressure),
        _in_contact(discrepancy, closed_form.pressure),
        {"tension": largest_tension},
        (evidence,),
    )


def _sharp_punch(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of a flat punch with sharp corners, p = P/(pi a sqrt(1 - xi^2)), largest at the edges
    (Johnson 1985, 2.8). None where the width changes: the edges of a punch do not move.
    `discrepancy` holds the tractions of result and reference.
    """
    closed_form = _closed_form(discrepancy, lambda xi: (1 / np.sqrt(1 - xi**2))[:, None])
    if closed_form is None:
        return None
    largest_half_width = float(closed_form.half_widths.max())
    least_half_width = float(closed_form.half_widths.min())
    largest_spacing = float(np.diff(discrepancy.x).max())
    if least_half_width < largest_half_width - 2 * largest_spacing:
        return None
    return ProblemFit(
        _with(discrepancy, PRESSURE, closed_form.pressure),
        discrepancy.reference_tractions,
        2 * len(closed_form.half_widths),
        _in_contact(discrepancy, closed_form.pressure),
        {"half_width": largest_half_width},
    )


def _sphere(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of a result's pressure by that of a sphere in place of the scene's cylinder: does the
    result solve the axisymmetric problem?

    Sphere: p = p0 sqrt(1 - xi^2), p0/a = 2 E*/(pi R), and P = 2 pi a^2 p0/3 is a force (Johnson
    1985, 4.2). A cylinder has p0/a = E*/(2 R). xi = x/a, with the half-width a that fits best at
    each instant. None where the profile is no parabola, and where no half-widths can be fitted.
    """
    profile = discrepancy.scene.profile
    if not isinstance(profile, Hertz):
        return None
    closed_form = _closed_form(discrepancy, lambda xi: np.sqrt(1 - xi**2)[:, None])
    if closed_form is None:
        return None
    scales = discrepancy.comparison.scales
    pressure_over_half_width = _SPHERE * scales.pressure / scales.half_width
    xi = discrepancy.x / closed_form.half_widths[:, None]
    pressure = (
        pressure_over_half_width
        * closed_form.half_widths[:, None]
        * np.sqrt(np.maximum(1 - xi**2, 0.0))
    )
    force = float(np.max(2 / 3 * np.pi * closed_form.half_widths**3 * pressure_over_half_width))
    return ProblemFit(
        _with(discrepancy, PRESSURE, pressure),
        discrepancy.reference_tractions,
        len(pressure),
        _in_contact(discrepancy, pressure),
        {"force": force},
    )


def _limit_of_pressure(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of a pressure that is cut off at a limit: p = min(limit, elastic pressure of a larger
    load), with the same limit at all instants, as plastic flow or wear flattens the middle. None
    where few points lie on a limit. `discrepancy` holds the tractions of result and reference.
    """
    if discrepancy.unsymmetric:
        return None
    contact = contact_of(discrepancy.scene.profile, discrepancy.scene.material)
    result_pressure = discrepancy.result_tractions[PRESSURE]
    limit = float(np.median(result_pressure[result_pressure > 0.9 * result_pressure.max()]))
    limited_pressures = []
    most_on_limit = 0
    for pressure, load, weight in zip(
        result_pressure, discrepancy.normal_load, discrepancy.weight, strict=True
    ):
        elastic_pressures = contact.pressure(discrepancy.x, load * _WIDER[:, None])
        trial_pressures = np.minimum(elastic_pressures, limit)
        best_trial = int(np.argmin(np.sum(weight * (pressure - trial_pressures) ** 2, axis=1)))
        limited_pressures.append(trial_pressures[best_trial])
        most_on_limit = max(
            most_on_limit, int(np.sum(elastic_pressures[best_trial] > _ABOVE_LIMIT * limit))
        )
    if most_on_limit < _FEWEST_ON_LIMIT:
        return None
    is_above_limit = discrepancy.reference_tractions[PRESSURE] > limit
    return ProblemFit(
        _with(discrepancy, PRESSURE, np.array(limited_pressures)),
        discrepancy.reference_tractions,
        len(limited_pressures) + 1,
        _in_contact(discrepancy, np.array(limited_pressures)),
        {"limit": limit / discrepancy.comparison.scales.pressure},
        (
            f"{most_on_limit} points of one instant have {limit:.4g}, and no point has more than"
            f" {result_pressure.max() / limit:.3g} times that, where the reference exceeds it at"
            f" {int(is_above_limit.sum())} points",
        ),
    )


# ------------------------------------------------------------------------------- features of rows
def _several_zones(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of gaps inside the contact of the reference, whose load the zones between them carry:
    rough or wavy faces.

    None where values are only missing from a table: they take their share of the load with them.
    `discrepancy` holds the tractions of result and reference.
    """
    result_pressure = discrepancy.result_tractions[PRESSURE]
    reference_pressure = discrepancy.reference_tractions[PRESSURE]
    largest_pressure = result_pressure.max(axis=1, keepdims=True)
    largest_of_reference = reference_pressure.max(axis=1, keepdims=True)
    is_well_inside = reference_pressure > _WELL_INSIDE * largest_of_reference
    is_open = (result_pressure <= _OPEN * largest_pressure) & is_well_inside
    gap_lengths = [
        length for is_open_at_instant in is_open for length in _lengths_of_runs(is_open_at_instant)
    ]
    long_gaps = sum(length >= _FEWEST_IN_GAP for length in gap_lengths)
    pressure_over_gaps = np.where(is_open, reference_pressure, 0.0)
    load_over_gaps = np.trapezoid(pressure_over_gaps, discrepancy.x, axis=1)
    load_of_reference = np.trapezoid(reference_pressure, discrepancy.x, axis=1)
    share_over_gaps = load_over_gaps / np.maximum(load_of_reference, 1e-300)
    has_few_gaps = long_gaps < _FEWEST_GAPS * len(result_pressure)
    if has_few_gaps or float(share_over_gaps[discrepancy.is_loaded].min()) < _LEAST_OVER_GAPS:
        return None
    if abs(discrepancy.resultant_ratio - 1) > _BALANCED:
        return None
    # the gaps themselves: open in the result, and nothing else is claimed
    return ProblemFit(
        _with(discrepancy, PRESSURE, np.where(is_open, 0.0, reference_pressure)),
        discrepancy.reference_tractions,
        1,
        is_open,
        {"gaps": long_gaps / len(result_pressure)},
        (
            f"over the gaps the reference carries {float(share_over_gaps.max()):.0%} of P; the sum"
            f" of the pressures is {discrepancy.resultant_ratio:.4g} P all the same",
        ),
    )


def _lengths_of_runs(row: NDArray[np.bool_]) -> list[int]:
    """Lengths of the runs of True.

    >>> _lengths_of_runs(np.array([True, True, False, True]))
    [2, 1]
    """
    ends = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
    return [int(end - start) for start, end in ends.reshape(-1, 2)]


def _not_elastic(discrepancy: Discrepancy) -> ProblemFit | None:
    """Find two instants with the same P, by the scene and by the sum of the pressures, whose
    pressures differ most. Of elastic half-planes the pressure depends on P alone.

    None where none differ. The part that is odd in x is left out: unlike bodies and bodies that
    tilt make it. `discrepancy` holds the tractions of result and reference.
    """
    if discrepancy.unsymmetric or len(discrepancy.rows) < 2:
        return None
    result_pressure = discrepancy.result_tractions[PRESSURE]
    even_pressure = (result_pressure + _mirrored(result_pressure, discrepancy.x)) / 2
    sums = np.trapezoid(result_pressure, discrepancy.x, axis=1)
    relative_change, first_instant, second_instant = _most_changed_instants(
        discrepancy, even_pressure, sums
    )
    difference = even_pressure[[first_instant]] - even_pressure[[second_instant]]
    difference = difference / discrepancy.comparison.scales.pressure
    residual_between = Residual(
        difference,
        discrepancy.weight[[first_instant]],
        (even_pressure[[first_instant]] != 0) | (even_pressure[[second_instant]] != 0),
    )
    is_smooth = (
        residual_between.noise < _SMOOTH * residual_between.square
        and residual_between.count >= _FEWEST_SMOOTH
    )
    if relative_change < _OTHER_PRESSURE or not is_smooth:
        return None
    # The two instants, each of which the other one would predict.
    swapped_tractions = discrepancy.reference_tractions.copy()
    swapped_tractions[PRESSURE, first_instant] = even_pressure[second_instant]
    swapped_tractions[PRESSURE, second_instant] = even_pressure[first_instant]
    ratio_of_sums = sums[first_instant] / sums[second_instant]
    judged_points = np.zeros(result_pressure.shape, dtype=bool)
    judged_points[[first_instant, second_instant]] = True
    return ProblemFit(
        _with(discrepancy, PRESSURE, even_pressure),
        swapped_tractions,
        1,
        judged_points,
        {
            "share": relative_change,
            "first": float(discrepancy.time[first_instant]),
            "second": float(discrepancy.time[second_instant]),
        },
        (f"the sums of both pressures agree to {abs(ratio_of_sums - 1):.1%}",),
    )


def _mirrored(rows: Array, x: Array) -> Array:
    """Values at -x."""
    return np.array([np.interp(-x, x, row, left=0.0, right=0.0) for row in rows])


# ---------------------------------------------------------------------------------------- the shear
def _most_changed_instants(
    discrepancy: Discrepancy, pressure: Array, sums: Array
) -> tuple[float, int, int]:
    """The two instants with the same P whose pressures differ most: root mean square difference
    over that of the reference's pressure, and their indices. (0, 0, 0) without such a pair.

    Parameters
    ----------
    discrepancy
        tractions of result and reference at some instants and all points
    pressure
        (k, n) of the result
    sums
        (k,) integrals of the pressure over x, which must agree as P does
    """
    load = discrepancy.normal_load
    reference_size = np.sqrt(np.mean(discrepancy.reference_tractions[PRESSURE] ** 2, axis=1))
    largest_change = (0.0, 0, 0)
    for first_instant in range(len(pressure)):
        for second_instant in range(first_instant + 1, len(pressure)):
            has_same_load = abs(load[first_instant] / load[second_instant] - 1) < _SAME_LOAD
            has_same_sum = abs(sums[first_instant] / sums[second_instant] - 1) < _SAME_LOAD
            if (
                discrepancy.is_loaded[first_instant]
                and discrepancy.is_loaded[second_instant]
                and has_same_load
                and has_same_sum
            ):
                change = float(
                    np.sqrt(np.mean((pressure[first_instant] - pressure[second_instant]) ** 2))
                )
                largest_change = max(
                    largest_change,
                    (change / float(reference_size[first_instant]), first_instant, second_instant),
                )
    return largest_change


def _rolling(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of tractive rolling, whose stick zone begins at the leading edge: q = f [p(x, P) - p(x -+
    (a - c), P - |Q|/f)] with the sign of Q (Carter 1926; Johnson 1985, 8.3).

    The side of the leading edge is the one that fits better. None without friction, shear or Q, for
    an unsymmetric scene, and where all slides at some instant. `discrepancy` holds the tractions of
    result and reference.
    """
    friction = discrepancy.scene.friction.coefficient
    if discrepancy.unsymmetric or not friction or not discrepancy.has_shear:
        return None
    loads = discrepancy.scene.load.path().at(discrepancy.time)
    normal_load = np.asarray(loads[0])[:, None]
    tangential_load = np.asarray(loads[1])[:, None]
    stick_load = normal_load - np.abs(tangential_load) / friction
    if np.any(stick_load <= 0) or np.all(np.abs(tangential_load) < 1e-9 * normal_load):
        return None
    contact = contact_of(discrepancy.scene.profile, discrepancy.scene.material)
    shifts = contact.half_width(normal_load) - contact.half_width(stick_load)
    pressure = contact.pressure(discrepancy.x, normal_load)
    least_square = np.inf
    for direction in (1.0, -1.0):
        stick_pressure = np.array(
            [
                contact.pressure(discrepancy.x - direction * shift, load)
                for shift, load in zip(shifts[:, 0], stick_load[:, 0], strict=True)
            ]
        )
        shear = np.sign(tangential_load) * friction * (pressure - stick_pressure)
        square = float(
            np.sum(discrepancy.weight * (discrepancy.result_tractions[SHEAR] - shear) ** 2)
        )
        if square < least_square:
            least_square = square
            best_shear = shear
            leading_side = "right" if direction > 0 else "left"
    return ProblemFit(
        _with(discrepancy, SHEAR, best_shear),
        discrepancy.reference_tractions,
        1,
        discrepancy.in_contact(discrepancy.reference_tractions),
        {"side": leading_side},
    )


def _law_of_friction(discrepancy: Discrepancy) -> ProblemFit | None:
    """Fit of |q| = constant + slope p where the reference slips: a law that is no coefficient of
    friction, such as a shear strength (slope 0) or cohesion (slope f).

    None where such a law fits no better. `discrepancy` holds the tractions of result and reference.
    """
    friction = discrepancy.scene.friction.coefficient
    if not friction or not discrepancy.has_shear:
        return None
    state = discrepancy.comparison.reference_cycle.state[discrepancy.rows]
    slip_direction = (state == SLIP_FORWARD) * 1.0 - (state == SLIP_REVERSE)
    slip_direction = np.where(
        slip_direction == 0, 0.0, np.sign(discrepancy.reference_tractions[SHEAR])
    )
    pressure = discrepancy.result_tractions[PRESSURE]
    slips = (slip_direction != 0) & (pressure > _OPEN * pressure.max()) & (discrepancy.weight > 0)
    shear = slip_direction * discrepancy.result_tractions[SHEAR]
    if slips.sum() < _FEWEST_IN_SLIP:
        return None
    p = pressure[slips]
    q = shear[slips]
    coefficient_alone = float(p @ q / (p @ p))
    (constant, slope), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(p), p]), q, rcond=None)
    square_left_by_coefficient = float(np.mean((q - coefficient_alone * p) ** 2))
    square_left = float(np.mean((q - constant - slope * p) ** 2))
    scale = discrepancy.comparison.scales.shear
    # a law through the origin is a coefficient of friction; one that falls is no law
    if constant < _LEAST_CONSTANT * scale or slope < -0.1 * friction:
        return None
    shear_by_law = np.where(
        slips,
        slip_direction * (constant + slope * pressure),
        discrepancy.reference_tractions[SHEAR],
    )
    shear_by_coefficient = np.where(
        slips, slip_direction * coefficient_alone * pressure, discrepancy.reference_tractions[SHEAR]
    )
    residual = discrepancy.residual(_with(discrepancy, SHEAR, shear_by_law), SHEAR)
    noise = min(replace(residual, is_inside=slips).noise * scale**2, square_left)
    # this law leaves hardly less than the best coefficient does
    if square_left - noise > _LEFT_OF_LAW**2 * (square_left_by_coefficient - noise):
        return None
    return ProblemFit(
        _with(discrepancy, SHEAR, shear_by_law),
        _with(discrepancy, SHEAR, shear_by_coefficient),
        1,
        slips,
        {"constant": float(constant), "slope": float(slope)},
        (
            f"{int(slips.sum())} points in slip; no coefficient of friction leaves less than"
            f" {square_left_by_coefficient**0.5 / scale:.2g} of f p_ref of their shear, this law"
            f" leaves {square_left**0.5 / scale:.2g}",
        ),
    )


PROBLEMS = (
    OtherProblem("several_zones", PRESSURE, _several_zones),
    OtherProblem("adhesion", PRESSURE, _adhesion),
    OtherProblem("sharp_punch", PRESSURE, _sharp_punch),
    OtherProblem("sphere", PRESSURE, _sphere),
    OtherProblem("limit_of_pressure", PRESSURE, _limit_of_pressure),
    OtherProblem("not_elastic", PRESSURE, _not_elastic),
    OtherProblem("rolling", SHEAR, _rolling),
    OtherProblem("law_of_friction", SHEAR, _law_of_friction),
)


def other_problems(discrepancy: Discrepancy, fit_named: Fit | None) -> Iterator[Diagnosis]:
    """The finding that the tractions belong to a problem which the suite does not solve, where one
    fits and the causes `fit_named` leave much more; else none. `discrepancy` holds the tractions of
    result and reference.
    """
    # Friction follows the pressure: where that is wrong, the shear shows no problem of its own.
    pressure_residual = discrepancy.residual(discrepancy.reference_tractions, PRESSURE)
    is_pressure_right = discrepancy.is_within(PRESSURE) or pressure_residual.is_noise
    candidates = []
    for problem in PROBLEMS:
        if problem.channel == SHEAR and not is_pressure_right:
            continue
        problem_fit = problem.fit(discrepancy)
        if problem_fit is None:
            continue
        residual_after = problem.residual(discrepancy, problem_fit.predicted, problem_fit)
        # what the scene itself, or the simpler law, leaves on the points of this problem
        residual_before = problem.residual(discrepancy, problem_fit.tractions_to_beat, problem_fit)
        noise = min(residual_after.noise, residual_after.square)
        share_left = share_of_norm(residual_after.square, residual_before.square, noise)
        chance = gain_by_chance(
            residual_after.square,
            residual_before.square,
            residual_after.count,
            n_parameters=problem_fit.parameters,
        )
        if share_left >= MOST_LEFT or chance >= CHANCE:
            continue
        if fit_named is not None:
            residual_of_causes = problem.residual(
                discrepancy, fit_named.predicted_tractions, problem_fit
            )
            is_apart = are_apart(
                residual_of_causes.square,
                residual_after.square,
                residual_after.count,
                is_noise=residual_after.is_noise,
            )
            if not is_apart:
                continue
        candidates.append((share_left, problem, problem_fit))
    if not candidates:
        return
    share_left, problem, problem_fit = min(candidates, key=lambda candidate: candidate[0])
    sentence = (
        f"{WORDS['other_problem']} {WORDS['problems'][problem.key].format(**problem_fit.figures)}"
    )
    evidence = (
        *problem_fit.evidence,
        f"tractions of that problem, its sizes fitted, leave {share_left:.1%} of the difference",
    )
    yield Diagnosis(problem.key, sentence, evidence, 1 - share_left)
