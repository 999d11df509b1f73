"""Whether the rows of a loop are of one steady loop of theory: drift of U, run-in, and cycles that
differ.

The distances of rows from the loop that fits them are scatter if the model holds: neighbours do
not know of each other. Where the model does not hold, neighbours lie on the same side of it, and
the correlation of neighbours says how much of the distances is no scatter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from reports.scoring.loop_branches import Branches, row_noise, sizes_of_cycles
from scenes.array_types import Array

# Correlation of neighbours in its standard deviations, 1/sqrt(n): chance exceeds three once in
# 700.
BY_CHANCE = 3.0
# Neighbours that are alike to this leave one row's worth in 40: no interval is widened more.
_MOST_ALIKE = 0.95
# Singular values of columns that are alike, over the largest.
_ALIKE_COLUMNS = 1e-8
# Blocks of neighbours whose means show a smooth part of the distances, and their least rows.
_BLOCKS = 40
_FEWEST_OF_BLOCK = 25
# Rows of which the branch is certain: this share of a branch is left out at both of its ends.
_AT_TURN = 0.1
# Pairs of rows a cycle apart that a drift is found from.
_FEWEST_PAIRS = 8
# Sizes of cycles that are alike differ by less: at 20 rows a cycle a size is known to 1 %.
_ALIKE = 0.03
# Largest difference between sizes of a few cycles by noise, in standard deviations of one.
_NOISE_OF_SIZES = 4.0
# Steps from one size to the next, half a cycle later, that part a period of two cycles from a
# trend.
_SHOWS_A_PERIOD = 3
# Standard error of a size by the places of its rows, times rows of a cycle.
_OF_A_SIZE = 0.1
# Standard errors from which on a trend is certain; below which two trends may be the same.
_CERTAIN = 4.0
# Of the squares of two trends in their standard errors, of U and of Q: chance exceeds it in 0.4 %.
_BOTH_CERTAIN = 11.0
_MAY_BE = 2.0


@dataclass(frozen=True)
class Misfit:
    """What the distances of rows (n,) from their fit say about the model.

    Attributes
    ----------
    correlation
        of neighbours, 0 where chance may have given it
    systematic
        rms of the part of the distances that is no scatter [length]
    """

    correlation: float
    systematic: float

    @property
    def widening(self) -> float:
        """Of an interval: the square root of rows over independent rows, (1 + r)/(1 - r)."""
        alike = min(self.correlation, _MOST_ALIKE)
        return math.sqrt((1 + alike) / (1 - alike))


def misfit_of(distances: Array, shift_noise: float, least_deviations: float = BY_CHANCE) -> Misfit:
    """How much of the distances of rows from a fit is no scatter: the correlation of neighbouring
    rows, and the systematic part in units of U. The latter follows from that correlation; with
    many rows also from the means of blocks of rows, and the smaller of both is taken.

    Parameters
    ----------
    distances
        (n,) in sigma
    shift_noise
        sigma of U [length]
    least_deviations
        a correlation of fewer standard deviations than this is taken for chance, and is 0

    Examples
    --------
    >>> bool(misfit_of(np.sin(np.arange(200) / 10), 1.0).correlation > 0.9)
    True
    >>> misfit_of(np.random.default_rng(1).standard_normal(200), 1.0).correlation
    0.0
    """
    deviation_from_mean = distances - np.mean(distances)
    sum_of_squares = float(deviation_from_mean @ deviation_from_mean)
    if sum_of_squares == 0:
        return Misfit(0.0, 0.0)
    correlation = float(deviation_from_mean[1:] @ deviation_from_mean[:-1]) / sum_of_squares
    if correlation * math.sqrt(len(deviation_from_mean)) <= least_deviations:
        return Misfit(0.0, 0.0)
    variance = sum_of_squares / len(deviation_from_mean)
    systematic_variance = correlation * variance
    rows_of_block = len(deviation_from_mean) // _BLOCKS
    if rows_of_block >= _FEWEST_OF_BLOCK:
        # Scatter vanishes from the mean of many rows, and a smooth deviation stays in it.
        block_means = (
            deviation_from_mean[: _BLOCKS * rows_of_block]
            .reshape(_BLOCKS, rows_of_block)
            .mean(axis=1)
        )
        variance_of_blocks = max(float(np.mean(block_means**2)) - variance / rows_of_block, 0.0)
        systematic_variance = min(systematic_variance, variance_of_blocks)
    return Misfit(correlation, math.sqrt(systematic_variance) * shift_noise)


@dataclass(frozen=True, eq=False)
class Change:
    """What more terms explain of the distances of rows, such as a change of the loop with time.

    Attributes
    ----------
    chance
        with which scatter alone explains as much
    rms
        of the distances that the terms explain, in sigma
    terms
        (k,) the terms; where they change with a number of the rows, per unit of it
    """

    chance: float
    rms: float
    terms: Array


NO_CHANGE = Change(1.0, 0.0, np.zeros(7))
"""Of rows of too few cycles to show one."""


def change_of(distances: Array, derivatives: Array, added: Array) -> Change:
    """Whether a fit with more parameters brings the rows nearer than chance does, by the F test:
    the chance, how much nearer (root mean square), and the values of the added parameters.

    Parameters
    ----------
    distances
        (n,) of the rows from their fit, in sigma
    derivatives
        (n, k) of the distances by the parameters of the fit
    added
        (n, j) of the distances by the parameters that are added

    Examples
    --------
    >>> random = np.random.default_rng(2)
    >>> rows = random.standard_normal((200, 2))
    >>> time = np.arange(200) / 200 - 0.5
    >>> with_time = rows * time[:, None]
    >>> steady = random.standard_normal(200)
    >>> change_of(steady, rows, with_time).chance > 0.05
    True
    >>> change_of(steady - 3 * with_time[:, 0], rows, with_time).chance < 1e-6
    True
    """
    from scipy.stats import f as fisher

    all_derivatives = np.column_stack([derivatives, added])
    sums_of_squares = []
    ranks = []
    for columns in (derivatives, all_derivatives):
        coefficients, _, rank, _ = np.linalg.lstsq(columns, distances, rcond=_ALIKE_COLUMNS)
        residual = distances - columns @ coefficients
        sums_of_squares.append(float(residual @ residual))
        ranks.append(int(rank))
    # a parameter moves against what it leaves
    added_values = np.asarray(-coefficients[derivatives.shape[1] :])
    n_added = ranks[1] - ranks[0]
    degrees_of_freedom = len(distances) - ranks[1]
    if n_added < 1 or degrees_of_freedom < 1 or sums_of_squares[1] == 0:
        return Change(1.0, 0.0, added_values)
    gain_of_squares = max(sums_of_squares[0] - sums_of_squares[1], 0.0)
    chance = float(
        fisher.sf(
            gain_of_squares / n_added / (sums_of_squares[1] / degrees_of_freedom),
            n_added,
            degrees_of_freedom,
        )
    )
    return Change(chance, math.sqrt(gain_of_squares / len(distances)), added_values)


def drift_of_shift(shift: Array, load: Array, time: Array, branches: Branches) -> float | None:
    """Rate at which U drifts from cycle to cycle [length per unit of time].

    U of a row is compared with U a cycle later, both minus the slope dU/dQ times Q. Rows near the
    turning points are left out. None where too few rows have another a cycle later.

    Parameters
    ----------
    shift
        (n,) U of the rows
    load
        (n,) Q of the rows
    time
        (n,) their times
    branches
        branch of each row, and the cycles that are over there
    """
    phase = np.maximum.accumulate(branches.phase)
    share_of_branch = np.mod(2 * branches.phase, 1.0)
    is_used = (
        (share_of_branch > _AT_TURN)
        & (share_of_branch < 1 - _AT_TURN)
        & (branches.phase + 1 < phase[-1])
    )
    if np.count_nonzero(is_used) < _FEWEST_PAIRS:
        return None
    phase_later = branches.phase[is_used] + 1
    slope = float(np.polyfit(load, shift, 1)[0])
    opened_shift = shift - slope * load
    drift_of_rows = np.interp(phase_later, phase, opened_shift) - opened_shift[is_used]
    time_of_rows = np.interp(phase_later, phase, time) - time[is_used]
    return float(np.mean(drift_of_rows) / np.mean(time_of_rows))


@dataclass(frozen=True)
class Trend:
    """By how much the size of a cycle grows in each cycle, over the mean size, and its standard
    error.
    """

    rate: float
    error: float

    @property
    def is_certain(self) -> bool:
        """Whether no scatter gives as much."""
        return abs(self.rate) > _CERTAIN * self.error

    def may_be(self, other: Trend) -> bool:
        """Whether scatter explains the difference from another one."""
        apart = abs(self.rate - other.rate)
        return apart < _MAY_BE * math.hypot(self.error, other.error)


def trend_of_sizes(values: Array, load: Array, time: Array, noise: float) -> Trend | None:
    """How the cycles of a record grow or shrink: rate per cycle over the median size, with its
    standard error, by the straight line through their sizes.

    A size is the standard deviation through a cycle. None where there are fewer than two sizes.

    Parameters
    ----------
    values
        (n,) the record, Q or U
    load, time, noise
        Q (n,) and its time, which part the cycles, and the sigma of Q

    Examples
    --------
    >>> cycles = np.arange(400) / 100
    >>> wave = np.cos(2 * np.pi * cycles)
    >>> growing = trend_of_sizes((1 + 0.1 * cycles) * wave, wave, cycles, 0.0)
    >>> bool(0.07 < growing.rate < 0.1 and growing.is_certain)
    True
    >>> trend_of_sizes(wave, wave, cycles, 0.0).is_certain
    False
    """
    sizes = sizes_of_cycles(values, load, time, noise)
    if len(sizes) < 2:
        return None
    cycle_numbers = np.arange(len(sizes)) / 2
    deviation_from_mean = cycle_numbers - np.mean(cycle_numbers)
    lever = deviation_from_mean / float(deviation_from_mean @ deviation_from_mean)
    median_size = float(np.median(sizes))
    rows_of_cycle = 2 * len(load) / (len(sizes) + 1)
    error_by_noise = row_noise(values) / (median_size * math.sqrt(rows_of_cycle))
    error_of_size = math.hypot(error_by_noise, _OF_A_SIZE / rows_of_cycle)
    # Half of the rows of a cycle are those of the next size.
    variance = error_of_size**2 * float(lever @ lever + lever[1:] @ lever[:-1])
    return Trend(float(lever @ sizes) / median_size, math.sqrt(variance))


def goes_on_growing(
    shift: Array, load: Array, time: Array, first_row: int, noise: float
) -> Literal["", "grow", "shrink"]:
    """Whether the cycles grow or shrink over all rows, and may still do so from the row `first_row`
    on: then the rows before it are no run-in. Empty where neither is so.

    Parameters
    ----------
    shift, load, time
        U, Q and time of the rows (n,)
    first_row
        number of the first row behind the supposed run-in
    noise
        sigma of Q
    """
    for values in (load, shift):
        trend_of_all = trend_of_sizes(values, load, time, noise)
        trend_of_later_rows = trend_of_sizes(
            values[first_row:], load[first_row:], time[first_row:], noise
        )
        if trend_of_all is None or trend_of_later_rows is None:
            continue
        if trend_of_all.is_certain and trend_of_later_rows.may_be(trend_of_all):
            return "grow" if trend_of_all.rate > 0 else "shrink"
    return ""


def differences_of_cycles(shift: Array, load: Array, time: Array, noise: float) -> str:
    """How the cycles of a measured loop differ from each other in size, in words: "its cycles grow:
    U of one cycle goes up and down by ... % more than of another". "" where they are alike.

    Parameters
    ----------
    shift, load, time
        relative tangential displacement U, load Q and time of the rows, (n,) each
    noise
        standard deviation of the noise of Q
    """
    for name, values in (("Q", load), ("U", shift)):
        sizes = sizes_of_cycles(values, load, time, noise)
        if len(sizes) < 2:
            return ""
        median_size = float(np.median(sizes))
        rows_of_cycle = 2 * len(load) / (len(sizes) + 1)
        range_by_noise = (
            _NOISE_OF_SIZES * row_noise(values) / (median_size * math.sqrt(rows_of_cycle))
        )
        changes = sizes / median_size - 1
        if float(np.ptp(changes)) < _ALIKE + range_by_noise:
            continue
        changes_to_next = np.diff(changes)
        extent_words = (
            f"{name} of one cycle goes up and down by {100 * float(np.ptp(changes)):.2g} % more"
            " than of another"
        )
        if np.all(changes_to_next > 0):
            return f"its cycles grow: {extent_words}"
        if np.all(changes_to_next < 0):
            return f"its cycles shrink: {extent_words}"
        if (
            len(changes_to_next) > _SHOWS_A_PERIOD
            and float(changes_to_next[2:] @ changes_to_next[:-2]) < 0
        ):
            return f"its period is another, every second cycle is alike: {extent_words}"
        return f"its cycles differ: {extent_words}"
    return _growth_through_noise(shift, load, time, noise)


def _growth_through_noise(shift: Array, load: Array, time: Array, noise: float) -> str:
    """How the cycles grow or shrink, in words, where the trends of U (`shift`) and Q (`load`)
    together are beyond their noise though neither is alone; "" where they are not. `noise` is the
    sigma of Q.
    """
    trends = [trend_of_sizes(values, load, time, noise) for values in (load, shift)]
    known_trends = [trend for trend in trends if trend is not None]
    if not known_trends:
        return ""
    steepest = max(known_trends, key=lambda trend: abs(trend.rate))
    sum_of_squared_ratios = sum((trend.rate / trend.error) ** 2 for trend in known_trends)
    cycles = len(sizes_of_cycles(load, load, time, noise)) / 2
    if sum_of_squared_ratios < _BOTH_CERTAIN or abs(steepest.rate) * cycles < _ALIKE:
        return ""
    verb = "grow" if steepest.rate > 0 else "shrink"
    return (
        f"its cycles {verb}, by {100 * abs(steepest.rate):.2g} % in each: U and Q together show it"
        " through their noise"
    )
