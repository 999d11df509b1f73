"""The area W of a measured loop of Q over U, and what it is uncertain by.

# notation: Q tangential load, U relative displacement, W area of the loop

Two ways. `polygon_area` goes through the rows in their order. `area_about_fit` takes the area of a
fitted loop, and adds to it what the rows enclose beside it: where a fit is at hand, no row need
close the loop, and the rows of all cycles count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.loop_masing import MasingLoop
from reports.scoring.loop_masing_fit import MasingFit
from scenes.array_types import Array

# Numbers of cycles passed that differ by less are the same but for rounding.
_ROUND_OFF_OF_CYCLES = 1e-9
# A loop is not closed where U of its two ends differs by more than 4.2 sigma of U, which is three
# sigma of a difference of two.
_TOLERATED_MISCLOSURE_IN_SIGMAS = 4.2
# A record may end one step of rows before its cycle does. Cycles passed are counted by Q: those of
# a harmonic Q at equal intervals of time have steps up to pi/2 times their mean, at the middle.
_MOST_MISSING_STEPS = 1.6
# Error of the area of a fitted loop by the samples of its curve, of itself: 2e-9 was measured.
_RELATIVE_ERROR_BY_SAMPLES = 1e-8
# Of the scatter of W: the rows choose branches, sigma and run-in too. Fitted on 1,156 loops (seeds
# 613 to 615 and 701 to 704 of benchmarks/measured_loops.py): a twentieth of them need it.
_FACTOR_ON_SCATTER = 1.12


@dataclass(frozen=True)
class LoopArea:
    """Area of a measured loop, the mean of its whole cycles [energy per thickness], and what it is
    uncertain by.

    Attributes
    ----------
    value
        the area W
    error_by_distance
        error by the distance between neighbouring rows: half of the difference from the area by
        every second row. That difference is three times the error, since a polygon with twice the
        step errs four times as much
    error_by_scatter
        1.96 standard deviations, from the scatter of U and Q
    n_cycles
        number of whole cycles
    """

    value: float
    error_by_distance: float
    error_by_scatter: float
    n_cycles: int

    @property
    def uncertainty(self) -> float:
        """Both together."""
        return math.hypot(self.error_by_distance, self.error_by_scatter)


def _area_of_polygon(displacement: Array, load: Array) -> float:
    """Closed integral of Q dU along the polygon (n,) and (n,), which ends where it begins."""
    return float(
        np.sum((load + np.roll(load, -1)) / 2 * (np.roll(displacement, -1) - displacement))
    )


def _where_displacement_returns(displacement: Array, rows: NDArray[np.intp]) -> tuple[int, float]:
    """Place in a record of rows at which the displacement U is nearest to its first value again,
    between two rows: the index of the row behind it, and the fraction of the step from the row
    before, 0 to 1.

    Parameters
    ----------
    displacement
        (n,) U of the rows
    rows
        (k,) indices of the rows at the ends of the steps that are searched

    Examples
    --------
    >>> _where_displacement_returns(np.array([2.0, 5.0, 1.0, 1.5, 2.5, 3.0]), np.array([3, 4, 5]))
    (4, 0.5)
    """
    displacement_before = displacement[rows - 1]
    change_of_step = displacement[rows] - displacement_before
    change_to_first = displacement[0] - displacement_before
    divisor = np.where(change_of_step == 0, 1.0, change_of_step)
    fraction_of_step = np.clip(change_to_first / divisor, 0.0, 1.0)
    nearest_step = int(np.argmin(np.abs(fraction_of_step * change_of_step - change_to_first)))
    return int(rows[nearest_step]), float(fraction_of_step[nearest_step])


def polygon_area(
    displacement: Array,
    load: Array,
    cycles_passed: Array,
    displacement_noise: float,
    load_noise: float,
) -> LoopArea:
    """Area W of a measured loop of Q over U per cycle [energy per thickness], by the polygon
    through its rows. With it come its errors by the distance of the rows and by their noise (95 %).
    As many whole cycles count as the rows cover, at least one. Where the last row does not meet the
    first one (misclosure), the area between them counts as an error.

    Parameters
    ----------
    displacement, load
        relative tangential displacement U and load Q of the rows, (n,) each
    cycles_passed
        (n,) number of cycles that have passed at each row, counted from any instant
    displacement_noise, load_noise
        sigma of U and Q

    Examples
    --------
    >>> angle = 2 * np.pi * np.arange(100) / 100
    >>> area = polygon_area(-np.sin(angle), np.cos(angle), angle / (2 * np.pi), 0.0, 0.0)
    >>> abs(area.value + np.pi) < area.error_by_distance < 0.01
    True

    # notation: sigma standard deviation of the noise
    """
    covered_cycles = float(cycles_passed[-1] - cycles_passed[0])
    # The last row may lie one step of rows (at most 1.6) before the end of a cycle; the
    # number of cycles passed is known to a hundredth.
    missing_cycles = _MOST_MISSING_STEPS * covered_cycles / (len(cycles_passed) - 1) + 0.01
    n_cycles = max(math.floor(covered_cycles + missing_cycles), 1)
    cycles_at_end = float(cycles_passed[0]) + n_cycles
    # rows at or after the end of the last whole cycle
    rows_at_end = np.flatnonzero(cycles_passed >= cycles_at_end)
    rows_at_end = rows_at_end[
        rows_at_end > 0.5 * len(cycles_passed) * n_cycles / max(covered_cycles, n_cycles)
    ]
    error_by_misclosure = 0.0
    if len(rows_at_end):
        noise_deviations = (displacement_noise, load_noise)
        displacement, load, error_by_misclosure = _closed_loop_and_misclosure_error(
            displacement, load, cycles_passed, rows_at_end, cycles_at_end, noise_deviations
        )
    elif cycles_at_end - cycles_passed[-1] > missing_cycles:
        # the loop may lie anywhere between the chord and its end tangents
        rectangle = float((displacement[-1] - displacement[0]) * (load[-1] - load[0]))
        error_by_misclosure = abs(rectangle) / 2

    # the error of a polygon grows with the square of its step: it is found from every second row
    area = _area_of_polygon(displacement, load)
    area_by_half_the_rows = (
        _area_of_polygon(displacement[::2], load[::2])
        + _area_of_polygon(displacement[1::2], load[1::2])
    ) / 2
    displacement_step = (np.roll(displacement, -1) - np.roll(displacement, 1)) / 2
    load_step = (np.roll(load, -1) - np.roll(load, 1)) / 2
    area_scatter = math.sqrt(
        float(np.sum((displacement_noise * load_step) ** 2 + (load_noise * displacement_step) ** 2))
    )
    error_by_distance = abs(area - area_by_half_the_rows) / 2 + error_by_misclosure
    return LoopArea(
        area / n_cycles, error_by_distance / n_cycles, 1.96 * area_scatter / n_cycles, n_cycles
    )


def _closed_loop_and_misclosure_error(
    displacement: Array,
    load: Array,
    cycles_passed: Array,
    rows_at_end: NDArray[np.intp],
    cycles_at_end: float,
    noise_deviations: tuple[float, float],
) -> tuple[Array, Array, float]:
    """Close a measured loop of Q over U at the end of its last whole cycle. Returns U and Q of the
    rows up to there, with an interpolated closing point as the last, and the error of the area
    because U does not return to its first value (misclosure) [energy per thickness].

    A chord at the first Q closes the loop. The true one may lie at the middle of the range of Q, so
    the error is the misclosure times the distance of the first Q from that middle. It is 0 for a
    misclosure that noise, or a last step that was not measured, may make.

    Parameters
    ----------
    displacement, load, cycles_passed
        (n,) U, Q, and number of cycles passed at each row
    rows_at_end
        indices of the rows at or after the end of the last whole cycle
    cycles_at_end
        cycles passed at that end
    noise_deviations
        sigma of U and of Q

    # notation: Q tangential load, sigma standard deviation of the noise, U relative tangential
    #           displacement
    """
    row_after, fraction_of_step, tolerated_misclosure = _end_of_cycle(
        displacement, load, cycles_passed, rows_at_end, cycles_at_end, noise_deviations
    )
    displacement_at_end, load_at_end = (
        float(
            values[row_after - 1] + fraction_of_step * (values[row_after] - values[row_after - 1])
        )
        for values in (displacement, load)
    )
    error_by_misclosure = 0.0
    misclosure = displacement_at_end - float(displacement[0])
    if abs(misclosure) > tolerated_misclosure:
        middle_load = float(load.max() + load.min()) / 2
        error_by_misclosure = abs(misclosure) * abs(float(load[0]) - middle_load)
    return (
        np.append(displacement[:row_after], displacement_at_end),
        np.append(load[:row_after], load_at_end),
        error_by_misclosure,
    )


def _end_of_cycle(
    displacement: Array,
    load: Array,
    cycles_passed: Array,
    rows_at_end: NDArray[np.intp],
    cycles_at_end: float,
    noise_deviations: tuple[float, float],
) -> tuple[int, float, float]:
    """Where the last whole cycle of a measured loop ends, between two rows: the index of the row
    behind, and the fraction of the step from the row before, 0 to 1. With them the tolerated
    misclosure [length]: the difference of U from the first row that noise, and a step from the last
    row to the first one that was not measured, may make.

    The cycle ends at `cycles_at_end`. At a turning point Q may stand still while U moves on, and
    the number of cycles passed, found from Q, stands too. Then the cycle ends where U is nearest to
    its first value.

    Parameters
    ----------
    displacement, load, cycles_passed
        (n,) relative tangential displacement U, tangential load Q, and number of cycles passed at
        each row
    rows_at_end
        indices of the rows at or after `cycles_at_end`
    noise_deviations
        standard deviations of the noise of U and of Q
    """
    displacement_noise, load_noise = noise_deviations
    row_after = int(rows_at_end[0])
    cycles_before = cycles_passed[row_after - 1]
    cycles_of_step = max(cycles_passed[row_after] - cycles_before, 1e-300)
    fraction_of_step = float(np.clip((cycles_at_end - cycles_before) / cycles_of_step, 0.0, 1.0))
    # 4.2 sigma
    tolerated_misclosure = _TOLERATED_MISCLOSURE_IN_SIGMAS * displacement_noise
    # part of a cycle in which Q changes by 4 sigma; a smaller change is none
    cycles_of_standstill = 4 * load_noise / (2 * float(np.ptp(load))) + _ROUND_OFF_OF_CYCLES
    rows_in_standstill = rows_at_end[
        cycles_passed[rows_at_end] <= cycles_at_end + cycles_of_standstill
    ]
    if len(rows_in_standstill) > 1:
        row_after, fraction_of_step = _where_displacement_returns(displacement, rows_in_standstill)
        is_last_row = row_after == len(displacement) - 1 and fraction_of_step == 1
        if is_last_row:
            largest_step = float(np.max(np.abs(np.diff(displacement[rows_in_standstill]))))
            tolerated_misclosure = max(tolerated_misclosure, _MOST_MISSING_STEPS * largest_step)
    return row_after, fraction_of_step, tolerated_misclosure


def area_about_fit(fitted_loop: MasingLoop, fit: MasingFit, cycles: float) -> LoopArea:
    """Area W of a measured loop of load Q over displacement U, per cycle [energy per thickness]:
    that of the fitted loop plus the area between this loop and the rows, with its errors.

    A row that lies beside the loop by (u, q) in U and Q stands for the piece of the loop between
    the midpoints to its neighbours. It changes W by the integral of q dU - u dQ over this piece, to
    first order. Scatter moves each row, and with it the fit: its drift of U above all, which one
    cycle hardly shows.

    Parameters
    ----------
    fitted_loop
        the fitted loop, by Masing's rule
    fit
        its parameters with their interval; `distances`, the signed distances of the n rows from the
        loop in sigma and their places along it; `error_by_digits`, the error of f by the last digit
        of Q
    cycles
        number of cycles that the rows cover

    # notation: f coefficient of friction, sigma standard deviation of the noise
    """
    place_on_loop = fit.distances.place_on_loop
    order_on_loop = np.argsort(place_on_loop, kind="stable")
    # (n,) change of W by a distance of one sigma of each row
    area_per_sigma = np.empty(len(place_on_loop))
    area_per_sigma[order_on_loop] = _area_per_sigma(fitted_loop, fit, order_on_loop)
    area_beside_fit = float(area_per_sigma @ fit.distances.signed_distance)
    # the same area by every second row along the loop, once from the first row and once from the
    # second
    area_beside_fit_by_half_the_rows = [
        float(
            _area_per_sigma(fitted_loop, fit, half_of_rows)
            @ fit.distances.signed_distance[half_of_rows]
        )
        for half_of_rows in _halves_of_rows(order_on_loop)
    ]

    error_by_scatter = _error_by_scatter(fitted_loop, fit, area_per_sigma)
    error_by_digits = 0.0
    if fit.error_by_digits:
        # derivative of W by f, times the error of f
        error_by_digits = fitted_loop.area_by_friction_where_gross * fit.error_by_digits
    # half of the difference to the areas by every second row
    error_by_distance = abs(area_beside_fit - sum(area_beside_fit_by_half_the_rows) / 2) / 2
    return LoopArea(
        value=fitted_loop.area + area_beside_fit,
        # the second term: error of the loop's area by samples of its curve
        error_by_distance=error_by_distance + _RELATIVE_ERROR_BY_SAMPLES * fitted_loop.area,
        error_by_scatter=math.hypot(error_by_scatter, error_by_digits),
        n_cycles=max(math.floor(cycles), 1),
    )


def _halves_of_rows(order: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Two halves of the rows, each every second one along the loop; `order` are their indices along
    it.
    """
    return order[::2], order[1::2]


def _error_by_scatter(fitted_loop: MasingLoop, fit: MasingFit, area_per_sigma: Array) -> float:
    """Error (95 %) of the area of a measured loop [energy per thickness] by the scatter of its
    rows. Scatter moves each row, and with it the fitted loop.

    Parameters
    ----------
    fitted_loop, fit
        the fitted loop, and the distances of the rows from it, in sigma, with their derivatives by
        its seven parameters. `degrees_of_freedom` is the number of rows minus that of fitted
        parameters; `misfit.widening` is the factor by which correlated neighbours widen an
        interval; `interval_ends` are parameters (7,) at both ends of the interval of f, or None
    area_per_sigma
        (n,) change of the area by a distance of one sigma of each row, where the loop stays

    # notation: f coefficient of friction, sigma standard deviation of the noise, W area of the loop
    """
    from scipy.stats import t as student

    # derivatives of the area by the seven parameters of the loop, (7,)
    whole_area_by_parameters = (
        fitted_loop.area_by_parameters + area_per_sigma @ fit.distances.derivatives
    )
    # derivatives (m,) of the area by the residuals of the fit, of which those of the n rows come
    # first: `influence` (7, m) is the change of the parameters by each residual
    area_by_residuals = whole_area_by_parameters @ fit.influence
    area_by_residuals[: len(area_per_sigma)] += area_per_sigma
    # The scatter is at least what the digits of the rows leave: sigma is no smaller.
    variance = max(
        float(fit.distances.signed_distance @ fit.distances.signed_distance)
        / fit.degrees_of_freedom,
        1.0,
    )
    # rows that deviate alike count as fewer rows
    widening = max(fit.misfit.widening, 1.0)
    sum_of_squares = float(area_by_residuals @ area_by_residuals)
    sigma_of_area = math.sqrt(variance * sum_of_squares) * widening
    # 97.5 % quantile of Student's t distribution: 1.96 for many rows
    student_factor = float(student.ppf(0.975, fit.degrees_of_freedom))
    # _FACTOR_ON_SCATTER: 1.12, fitted on 1,156 loops
    error_by_scatter = _FACTOR_ON_SCATTER * student_factor * sigma_of_area
    # W of a thin loop is no straight function of the rows: over the interval of f it changes more.
    # A loop without an upper limit of f may be a line, which has no area.
    for parameters_at_end in fit.interval_ends:
        area_at_end = 0.0
        if parameters_at_end is not None:
            area_at_end = replace(fitted_loop, parameters=parameters_at_end).area
        error_by_scatter = max(error_by_scatter, abs(area_at_end - fitted_loop.area))
    return error_by_scatter


def _area_per_sigma(fitted_loop: MasingLoop, fit: MasingFit, rows: NDArray[np.intp]) -> Array:
    """Change of the area W of a measured loop [energy per thickness] if a row lies one sigma away
    from the fitted loop, for each of the `rows`: (k,).

        dW = n_Q sigma_Q (change of U) - n_U sigma_U (change of Q)

    n is the unit normal of the loop at the row. The changes of U and Q are those along the loop
    between the midpoints to the row before and to the row behind.

    Parameters
    ----------
    fitted_loop
        the fitted loop
    fit
        `distances`: unit normal (n, 2) of the loop and place along it (n,), 0 to 1 on the rising
        and 1 to 2 on the falling branch; `sigma` of the noise of U and of Q
    rows
        (k,) indices of rows, in their order along the loop

    # notation: Q tangential load, sigma standard deviation of the noise, U relative tangential
    #           displacement
    """
    place = fit.distances.place_on_loop[rows]
    unit_normal = fit.distances.unit_normal[rows]
    # places are counted round the loop, from 0 to 2: the first row follows the last one
    place_before = np.concatenate([[place[-1] - 2], place[:-1]])
    place_after = np.concatenate([place[1:], [place[0] + 2]])
    # U and Q of the loop at the midpoints, from its middle
    displacement_before, load_before = fitted_loop.points_at_rows(
        np.mod((place_before + place) / 2, 2.0)
    )
    displacement_after, load_after = fitted_loop.points_at_rows(
        np.mod((place + place_after) / 2, 2.0)
    )
    area_by_load_error = (
        unit_normal[:, 1] * fit.sigma.of_load * (displacement_after - displacement_before)
    )
    area_by_displacement_error = (
        unit_normal[:, 0] * fit.sigma.of_displacement * (load_after - load_before)
    )
    return np.asarray(area_by_load_error - area_by_displacement_error)
