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

# Phases closer than this are alike but for rounding.
_ROUNDING = 1e-9
# Sigma of U beyond which rows do not come back to the first one: three of a difference of two.
_GAP = 4.2
# Error of the area of a fitted loop by the samples of its curve, of itself: 2e-9 was measured.
_OF_SAMPLES = 1e-8
# Of the scatter of W: the rows choose branches, sigma and run-in too. Fitted on 1,156 loops (seeds
# 613 to 615 and 701 to 704 of benchmarks/measured_loops.py): a twentieth of them need it.
_CHOSEN_BY_ROWS = 1.12


@dataclass(frozen=True)
class LoopArea:
    """Area of the polygon of the rows, the mean of whole cycles [energy per thickness], and what it
    is uncertain by.

    Attributes
    ----------
    by_distance
        of the rows from each other: a polygon of twice the step errs four times as much. That
        is three times the error; half of the difference is stated
    by_noise
        1.96 standard deviations, from the scatter of U and Q
    """

    value: float
    by_distance: float
    by_noise: float
    cycles: int

    @property
    def uncertainty(self) -> float:
        """Both together."""
        return math.hypot(self.by_distance, self.by_noise)


def _shoelace(shift: Array, load: Array) -> float:
    """Closed integral of Q dU along the polygon (n,) and (n,), which ends where it begins."""
    return float(np.sum((load + np.roll(load, -1)) / 2 * (np.roll(shift, -1) - shift)))


def _where_shift_returns(shift: Array, rows: NDArray[np.intp]) -> tuple[int, float]:
    """Where a record of U comes back nearest to its first value: the row behind that place, and the
    share of the step to this row.

    Parameters
    ----------
    shift
        (n,) U
    rows
        (k,) the rows behind the steps that are searched


    Examples
    --------
    >>> _where_shift_returns(np.array([2.0, 5.0, 1.0, 1.5, 2.5, 3.0]), np.array([3, 4, 5]))
    (4, 0.5)
    """
    shift_before = shift[rows - 1]
    step = shift[rows] - shift_before
    distance_to_first = shift[0] - shift_before
    share = np.clip(distance_to_first / np.where(step == 0, 1.0, step), 0.0, 1.0)
    nearest = int(np.argmin(np.abs(share * step - distance_to_first)))
    return int(rows[nearest]), float(share[nearest])


def polygon_area(
    shift: Array, load: Array, phase: Array, shift_noise: float, load_noise: float
) -> LoopArea:
    """Area W of a loop of Q over U per cycle, by the polygon through its rows, with its errors by
    the distance of the rows and by their noise. As many whole cycles count as the rows cover.

    Parameters
    ----------
    shift, load
        relative tangential displacement U and load Q of the rows, (n,) each
    phase
        (n,) cycles since any instant
    shift_noise, load_noise
        sigma of U and Q

    Examples
    --------
    >>> angle = 2 * np.pi * np.arange(100) / 100
    >>> found = polygon_area(-np.sin(angle), np.cos(angle), angle / (2 * np.pi), 0.0, 0.0)
    >>> abs(found.value + np.pi) < found.by_distance < 0.01
    True
    """
    covered_cycles = float(phase[-1] - phase[0])
    # A row is missing where the last one is a step before the first; phases are known to a
    # hundredth.
    missing_cycles = 1.6 * covered_cycles / (len(phase) - 1) + 0.01
    cycles = max(math.floor(covered_cycles + missing_cycles), 1)
    end = float(phase[0]) + cycles
    rows_at_end = np.flatnonzero(phase >= end)
    rows_at_end = rows_at_end[rows_at_end > 0.5 * len(phase) * cycles / max(covered_cycles, cycles)]
    area_of_gap = 0.0
    if len(rows_at_end):
        noise = (shift_noise, load_noise)
        shift, load, area_of_gap = _closed_at_end(shift, load, phase, rows_at_end, end, noise)
    elif end - phase[-1] > missing_cycles:
        # the loop may lie anywhere between the chord and its end tangents
        area_of_gap = abs(float((shift[-1] - shift[0]) * (load[-1] - load[0]))) / 2
    area = _shoelace(shift, load)
    area_of_half_the_rows = (
        _shoelace(shift[::2], load[::2]) + _shoelace(shift[1::2], load[1::2])
    ) / 2
    shift_step = (np.roll(shift, -1) - np.roll(shift, 1)) / 2
    load_step = (np.roll(load, -1) - np.roll(load, 1)) / 2
    area_scatter = math.sqrt(
        float(np.sum((shift_noise * load_step) ** 2 + (load_noise * shift_step) ** 2))
    )
    error_by_distance = abs(area - area_of_half_the_rows) / 2 + area_of_gap
    return LoopArea(area / cycles, error_by_distance / cycles, 1.96 * area_scatter / cycles, cycles)


def _closed_at_end(
    shift: Array,
    load: Array,
    phase: Array,
    rows_at_end: NDArray[np.intp],
    end: float,
    noise: tuple[float, float],
) -> tuple[Array, Array, float]:
    """U and Q of the rows up to the place between two rows where the loop closes, with that place
    as the last; and the area that is open where U does not come back there.

    Parameters
    ----------
    shift, load, phase
        (n,) U, Q, and the cycles that are over at each row
    rows_at_end
        rows behind the end of the last whole cycle
    end
        cycles that are over there
    noise
        sigma of U and of Q
    """
    shift_noise, load_noise = noise
    row_after = int(rows_at_end[0])
    phase_before = phase[row_after - 1]
    phase_step = max(phase[row_after] - phase_before, 1e-300)
    share_of_step = float(np.clip((end - phase_before) / phase_step, 0.0, 1.0))
    least_gap = _GAP * shift_noise
    phase_while_standing = 4 * load_noise / (2 * float(np.ptp(load))) + _ROUNDING
    standing_rows = rows_at_end[phase[rows_at_end] <= end + phase_while_standing]
    if len(standing_rows) > 1:  # U moves on while Q stands: the loop closes where U comes back
        row_after, share_of_step = _where_shift_returns(shift, standing_rows)
        is_last_row = row_after == len(shift) - 1 and share_of_step == 1
        if is_last_row:  # which may be a step before the first one
            largest_step = float(np.max(np.abs(np.diff(shift[standing_rows]))))
            least_gap = max(least_gap, 1.6 * largest_step)
    shift_at_end, load_at_end = (
        float(values[row_after - 1] + share_of_step * (values[row_after] - values[row_after - 1]))
        for values in (shift, load)
    )
    # U that does not come back closes by a chord at the first Q: an error of the gap times Q from
    # its mean there.
    area_of_gap = 0.0
    shift_across_gap = shift_at_end - float(shift[0])
    if abs(shift_across_gap) > least_gap:
        middle_load = float(load.max() + load.min()) / 2
        area_of_gap = abs(shift_across_gap) * abs(float(load[0]) - middle_load)
    return (
        np.append(shift[:row_after], shift_at_end),
        np.append(load[:row_after], load_at_end),
        area_of_gap,
    )


def area_about_fit(loop: MasingLoop, fit: MasingFit, cycles: float) -> LoopArea:
    """Area W of a measured loop of load Q over displacement U, per cycle: that of the fitted loop
    plus what the rows enclose beside it, with its errors.

    A row that lies beside the loop by (dU, dQ) stands for the loop from half-way to its neighbours:
    dW = integral of dQ dU - dU dQ, to first order in the distance. Scatter moves each row, and with
    it the fit: drift above all, which one cycle hardly shows.

    Parameters
    ----------
    loop
        the fitted loop, of the theory of friction memory
    fit
        its parameters with their interval, and the distances of the rows from it
    cycles
        how many the rows cover
    """
    places_on_loop = fit.distances.place
    order_on_loop = np.argsort(places_on_loop, kind="stable")
    area_by_distance = np.empty(len(places_on_loop))
    area_by_distance[order_on_loop] = _lever(loop, fit, order_on_loop)
    area_beside_fit = float(area_by_distance @ fit.distances.value)
    area_beside_halves = [
        float(_lever(loop, fit, half_of_rows) @ fit.distances.value[half_of_rows])
        for half_of_rows in _halves(order_on_loop)
    ]

    error_by_scatter = _error_by_scatter(loop, fit, area_by_distance)
    error_by_digits = 0.0
    if fit.by_digits:
        error_by_digits = loop.area_by_friction_where_gross * fit.by_digits
    error_by_distance = abs(area_beside_fit - sum(area_beside_halves) / 2) / 2
    return LoopArea(
        value=loop.area + area_beside_fit,
        by_distance=error_by_distance + _OF_SAMPLES * loop.area,
        by_noise=math.hypot(error_by_scatter, error_by_digits),
        cycles=max(math.floor(cycles), 1),
    )


def _halves(order: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Two halves of the rows, each every second one along the loop; `order` are their indices along
    it.
    """
    return order[::2], order[1::2]


def _error_by_scatter(loop: MasingLoop, fit: MasingFit, area_by_distance: Array) -> float:
    """Error (95 %) of the area of a measured loop by the scatter of its rows, which moves each row,
    and with it the fitted loop.

    Parameters
    ----------
    loop, fit
        the fitted loop, and its parameters with the distances of the rows
    area_by_distance
        (n,) change of the area by a distance of one sigma of each row, where the loop stays
    """
    from scipy.stats import t as student

    area_by_parameters = loop.area_by_parameters + area_by_distance @ fit.distances.derivatives
    area_by_row = area_by_parameters @ fit.influence
    area_by_row[: len(area_by_distance)] += area_by_distance
    # The scatter is at least what the digits of the rows leave: sigma is no smaller.
    variance = max(float(fit.distances.value @ fit.distances.value) / fit.freedom, 1.0)
    area_scatter = math.sqrt(variance * float(area_by_row @ area_by_row)) * max(
        fit.misfit.widening, 1.0
    )
    error_by_scatter = _CHOSEN_BY_ROWS * float(student.ppf(0.975, fit.freedom)) * area_scatter
    # W of a thin loop is no straight function of the rows: over the interval of f it changes more.
    # A loop without an upper limit of f may be a line.
    for parameters_at_end in fit.ends:
        area_at_end = (
            0.0 if parameters_at_end is None else replace(loop, values=parameters_at_end).area
        )
        error_by_scatter = max(error_by_scatter, abs(area_at_end - loop.area))
    return error_by_scatter


def _lever(loop: MasingLoop, fit: MasingFit, rows: NDArray[np.intp]) -> Array:
    """What a distance of one sigma between a row and the fitted loop adds to the area W, for each
    of the `rows` (their indices, in order along the loop), (len(rows),). Each stands for the loop
    from half-way to its neighbours among them.
    """
    place = fit.distances.place[rows]
    across = fit.distances.across[rows]
    # places go round the loop from 0 to 2: the first row follows the last one
    place_before = np.concatenate([[place[-1] - 2], place[:-1]])
    place_behind = np.concatenate([place[1:], [place[0] + 2]])
    shift_before, load_before = loop.at_rows(np.mod((place_before + place) / 2, 2.0))
    shift_behind, load_behind = loop.at_rows(np.mod((place + place_behind) / 2, 2.0))
    by_load = across[:, 1] * fit.weights.load * (shift_behind - shift_before)
    by_shift = across[:, 0] * fit.weights.shift * (load_behind - load_before)
    return np.asarray(by_load - by_shift)
