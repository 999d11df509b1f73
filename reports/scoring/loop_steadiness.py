"""Whether the rows of a loop are of one steady loop of theory: drift of U, run-in, and cycles that
differ.

The distances of rows from the loop that fits them are scatter if the model holds: neighbours are
not correlated. Where the model does not hold, neighbours lie on the same side of it, and their
correlation shows how much of the distances is no scatter.
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
MOST_DEVIATIONS_BY_CHANCE = 3.0
# A correlation of neighbours this large leaves one row's worth in 40: no interval is widened more.
_LARGEST_CORRELATION = 0.95
# Singular values over the largest one, below which columns of a fit count as linearly dependent.
_LEAST_RATIO_OF_SINGULAR_VALUES = 1e-8
# Blocks of neighbours whose means show a smooth part of the distances, and their least rows.
_N_BLOCKS = 40
_FEWEST_ROWS_OF_BLOCK = 25
# Rows of which the branch is certain: this share of a branch is left out at both of its ends.
_SHARE_AT_TURN = 0.1
# Pairs of rows a cycle apart that a drift is found from.
_FEWEST_PAIRS = 8
# Sizes of cycles that are alike differ by less: at 20 rows a cycle a size is known to 1 %. A size
# is the standard deviation of a quantity through a cycle.
_LEAST_DIFFERENCE_OF_SIZES = 0.03
# Largest difference between sizes of a few cycles by noise, in standard deviations of one.
_RANGE_OF_NOISE = 4.0
# Steps from one size to the next, half a cycle later, that part a period of two cycles from a
# trend.
_FEWEST_STEPS_OF_PERIOD = 3
# Standard error of a size by the places of its rows, times rows of a cycle.
_ERROR_OF_SIZE = 0.1
# Standard errors from which on a trend is certain.
_ERRORS_OF_CERTAIN_TREND = 4.0
# Sum of the squares of two trends, of U and of Q, over their standard errors: chance exceeds it in
# 0.4 %.
_SQUARES_OF_CERTAIN_TRENDS = 11.0
# Standard errors of their difference below which two trends may be the same.
_ERRORS_OF_SAME_TREND = 2.0


@dataclass(frozen=True)
class Misfit:
    """How much of the distances of rows from a fitted loop is no scatter.

    Attributes
    ----------
    correlation
        of the distances of neighbouring rows, 0 where chance may have given it
    systematic_rms
        root mean square of the part of the distances that is no scatter [length]
    """

    correlation: float
    systematic_rms: float

    @property
    def widening(self) -> float:
        """Factor by which the correlation r of neighbours widens an interval: the square root of
        the number of rows over that of independent rows, sqrt((1 + r)/(1 - r)).
        """
        correlation = min(self.correlation, _LARGEST_CORRELATION)
        return math.sqrt((1 + correlation) / (1 - correlation))


def misfit_of(
    distances: Array, displacement_noise: float, least_deviations: float = MOST_DEVIATIONS_BY_CHANCE
) -> Misfit:
    """How much of the distances of rows of a measured loop from a fit is no scatter: the
    correlation of neighbouring rows, and the systematic part of the distances in units of U, the
    displacement. This part follows from that correlation; with 1,000 rows and more also from the
    means of 40 blocks of rows, and the smaller of both is taken.

    Parameters
    ----------
    distances
        (n,) over sigma, the standard deviation of the noise, in the order of neighbours
    displacement_noise
        sigma of U [length]
    least_deviations
        a correlation of fewer standard deviations, 1/sqrt(n), than this is taken for chance; both
        values of the returned misfit are then 0

    Examples
    --------
    >>> bool(misfit_of(np.sin(np.arange(200) / 10), 1.0).correlation > 0.9)
    True
    >>> misfit_of(np.random.default_rng(1).standard_normal(200), 1.0).correlation
    0.0
    """
    deviations_from_mean = distances - np.mean(distances)
    sum_of_squares = float(deviations_from_mean @ deviations_from_mean)
    if sum_of_squares == 0:
        return Misfit(0.0, 0.0)
    correlation = float(deviations_from_mean[1:] @ deviations_from_mean[:-1]) / sum_of_squares
    if correlation * math.sqrt(len(deviations_from_mean)) <= least_deviations:
        return Misfit(0.0, 0.0)
    variance = sum_of_squares / len(deviations_from_mean)
    systematic_variance = correlation * variance
    rows_of_block = len(deviations_from_mean) // _N_BLOCKS
    if rows_of_block >= _FEWEST_ROWS_OF_BLOCK:
        # Scatter vanishes from the mean of many rows, and a smooth deviation stays in it.
        block_means = (
            deviations_from_mean[: _N_BLOCKS * rows_of_block]
            .reshape(_N_BLOCKS, rows_of_block)
            .mean(axis=1)
        )
        variance_of_blocks = max(float(np.mean(block_means**2)) - variance / rows_of_block, 0.0)
        systematic_variance = min(systematic_variance, variance_of_blocks)
    return Misfit(correlation, math.sqrt(systematic_variance) * displacement_noise)


@dataclass(frozen=True, eq=False)
class ExplainedChange:
    """What further parameters of a loop explain of the distances of rows from it, such as a change
    of the loop with time.

    Attributes
    ----------
    chance
        with which scatter alone explains as much
    explained_rms
        root mean square of the distances that they explain, in sigma
    added_values
        (k,) values of these parameters; of a change with a number of the rows, per unit of it
    """

    chance: float
    explained_rms: float
    added_values: Array


NO_CHANGE = ExplainedChange(1.0, 0.0, np.zeros(7))
"""The change that is taken for rows of too few cycles to show one."""


def explained_change(
    distances: Array, derivatives: Array, added_derivatives: Array
) -> ExplainedChange:
    """Whether a fit with further parameters brings rows nearer to it than chance does, by the F
    test. Returns the chance of scatter alone to bring them as near; the root mean square of the
    distances that the added parameters explain; and the values of these. The chance is 1 where the
    fit leaves nothing to explain.

    Parameters
    ----------
    distances
        (n,) of the rows from their fit, in sigma
    derivatives
        (n, k) of the distances by the parameters of the fit
    added_derivatives
        (n, j) of the distances by the parameters that are added

    Examples
    --------
    >>> random = np.random.default_rng(2)
    >>> derivatives = random.standard_normal((200, 2))
    >>> time = np.arange(200) / 200 - 0.5
    >>> by_growth = derivatives * time[:, None]
    >>> scatter = random.standard_normal(200)
    >>> explained_change(scatter, derivatives, by_growth).chance > 0.05
    True
    >>> explained_change(scatter - 3 * by_growth[:, 0], derivatives, by_growth).chance < 1e-6
    True

    # notation: sigma standard deviation of the noise
    """
    from scipy.stats import f as f_distribution

    sums_of_squares = []
    ranks = []
    for columns in (derivatives, np.column_stack([derivatives, added_derivatives])):
        # least squares without, then with the added parameters; singular values below 1e-8 of the
        # largest count as 0
        coefficients, _, rank, _ = np.linalg.lstsq(
            columns, distances, rcond=_LEAST_RATIO_OF_SINGULAR_VALUES
        )
        residuals = distances - columns @ coefficients
        sums_of_squares.append(float(residuals @ residuals))
        ranks.append(int(rank))
    sum_without_added, sum_with_added = sums_of_squares
    # parameters change so that they undo the distances
    added_values = np.asarray(-coefficients[derivatives.shape[1] :])
    n_added = ranks[1] - ranks[0]
    degrees_of_freedom = len(distances) - ranks[1]
    if n_added < 1 or degrees_of_freedom < 1 or sum_with_added == 0:
        return ExplainedChange(chance=1.0, explained_rms=0.0, added_values=added_values)
    explained_sum = max(sum_without_added - sum_with_added, 0.0)
    # variance by the added parameters over the variance that is left
    f_value = explained_sum / n_added / (sum_with_added / degrees_of_freedom)
    return ExplainedChange(
        chance=float(f_distribution.sf(f_value, n_added, degrees_of_freedom)),
        explained_rms=math.sqrt(explained_sum / len(distances)),
        added_values=added_values,
    )


def drift_of_displacement(
    displacement: Array, load: Array, time: Array, branches: Branches
) -> float | None:
    """Rate at which U, the displacement of a measured loop, drifts from cycle to cycle [length per
    unit of time].

    U of a row is compared with U a cycle later, both minus the slope dU/dQ times Q. Rows near the
    turning points are left out. None where too few rows have another a cycle later.

    Parameters
    ----------
    displacement, load, time
        U, Q and time of the rows, (n,) each
    branches
        branch of each row, and `cycles_passed`, the number of cycles that have passed at it

    # notation: Q tangential load
    """
    ascending_cycles_passed = np.maximum.accumulate(branches.cycles_passed)
    # a branch is half a cycle; _SHARE_AT_TURN: a tenth of a branch
    share_of_branch = np.mod(2 * branches.cycles_passed, 1.0)
    is_away_from_turns = (share_of_branch > _SHARE_AT_TURN) & (share_of_branch < 1 - _SHARE_AT_TURN)
    has_later_row = branches.cycles_passed + 1 < ascending_cycles_passed[-1]
    is_compared = is_away_from_turns & has_later_row
    # eight pairs of rows
    if np.count_nonzero(is_compared) < _FEWEST_PAIRS:
        return None
    cycles_a_cycle_later = branches.cycles_passed[is_compared] + 1
    slope = float(np.polyfit(load, displacement, 1)[0])
    displacement_beside_line = displacement - slope * load
    displacement_a_cycle_later = np.interp(
        cycles_a_cycle_later, ascending_cycles_passed, displacement_beside_line
    )
    time_a_cycle_later = np.interp(cycles_a_cycle_later, ascending_cycles_passed, time)
    changes_of_displacement = displacement_a_cycle_later - displacement_beside_line[is_compared]
    periods = time_a_cycle_later - time[is_compared]
    return float(np.mean(changes_of_displacement) / np.mean(periods))


@dataclass(frozen=True)
class Trend:
    """How the size of a cycle grows: `rate` is the growth in each cycle over the median size,
    negative where cycles shrink; `error` is its standard error.
    """

    rate: float
    error: float

    @property
    def is_certain(self) -> bool:
        """Whether no scatter gives as much."""
        return abs(self.rate) > _ERRORS_OF_CERTAIN_TREND * self.error

    def may_equal(self, other: Trend) -> bool:
        """Whether scatter explains the difference from another trend."""
        difference = abs(self.rate - other.rate)
        return difference < _ERRORS_OF_SAME_TREND * math.hypot(self.error, other.error)


def trend_of_sizes(values: Array, load: Array, time: Array, load_noise: float) -> Trend | None:
    """How the cycles of a measured loop grow or shrink in U or Q: the growth of their size in each
    cycle over the median size, with its standard error, by the straight line through their sizes.

    The size of a cycle is the standard deviation of U or Q through it. None where there are fewer
    than two sizes.

    Parameters
    ----------
    values
        (n,) Q or U of the rows
    load, time, load_noise
        Q (n,) and its time, by which cycles are found, and the standard deviation of the noise of Q

    Examples
    --------
    >>> cycles = np.arange(400) / 100
    >>> wave = np.cos(2 * np.pi * cycles)
    >>> growing = trend_of_sizes((1 + 0.1 * cycles) * wave, wave, cycles, 0.0)
    >>> bool(0.07 < growing.rate < 0.1 and growing.is_certain)
    True
    >>> trend_of_sizes(wave, wave, cycles, 0.0).is_certain
    False

    # notation: Q tangential load, U relative tangential displacement
    """
    # size of each cycle, (k,)
    sizes = sizes_of_cycles(values, load, time, load_noise)
    if len(sizes) < 2:
        return None
    # each cycle begins half a cycle after the one before
    cycle_numbers = np.arange(len(sizes)) / 2
    deviation_from_mean = cycle_numbers - np.mean(cycle_numbers)
    # the slope of the straight line is the sum of the sizes times these weights
    weights = deviation_from_mean / float(deviation_from_mean @ deviation_from_mean)
    median_size = float(np.median(sizes))
    rows_per_cycle = 2 * len(load) / (len(sizes) + 1)
    error_by_noise = row_noise(values) / (median_size * math.sqrt(rows_per_cycle))
    # the second term: error by the places of a cycle's rows
    error_of_size = math.hypot(error_by_noise, _ERROR_OF_SIZE / rows_per_cycle)
    # neighbouring sizes share half of their rows: half of the variance is their covariance
    variance = error_of_size**2 * float(weights @ weights + weights[1:] @ weights[:-1])
    return Trend(rate=float(weights @ sizes) / median_size, error=math.sqrt(variance))


def lasting_growth(
    displacement: Array, load: Array, time: Array, first_row: int, load_noise: float
) -> Literal["", "grow", "shrink"]:
    """Whether the cycles of a measured loop "grow" or "shrink" in Q or U, over all rows and perhaps
    at the same rate from the row `first_row` on. Then the rows before it are no run-in. "" where
    this is not so.

    Parameters
    ----------
    displacement, load, time
        U, Q and time of the rows, (n,) each
    first_row
        index of the first row behind the supposed run-in
    load_noise
        standard deviation of the noise of Q

    # notation: Q tangential load, U relative tangential displacement
    """
    for values in (load, displacement):
        # growth of the size of a cycle over the median one, with its error; None for fewer than
        # two
        trend_of_all_rows = trend_of_sizes(values, load, time, load_noise)
        trend_of_later_rows = trend_of_sizes(
            values[first_row:], load[first_row:], time[first_row:], load_noise
        )
        if trend_of_all_rows is None or trend_of_later_rows is None:
            continue
        # four standard errors; the trends differ by less than two
        if trend_of_all_rows.is_certain and trend_of_later_rows.may_equal(trend_of_all_rows):
            return "grow" if trend_of_all_rows.rate > 0 else "shrink"
    return ""


def differences_of_cycles_in_words(
    displacement: Array, load: Array, time: Array, load_noise: float
) -> str:
    """How the cycles of a measured loop differ from each other in size, in words: "its cycles grow:
    U of one cycle goes up and down by ... % more than of another". "" where they are alike. The
    size of a cycle is the standard deviation of Q or U through it.

    Parameters
    ----------
    displacement, load, time
        relative tangential displacement U, load Q and time of the rows, (n,) each
    load_noise
        standard deviation of the noise of Q
    """
    for name, values in (("Q", load), ("U", displacement)):
        # (k,), each of a cycle that begins half a cycle after the one before
        sizes = sizes_of_cycles(values, load, time, load_noise)
        if len(sizes) < 2:
            return ""
        median_size = float(np.median(sizes))
        rows_per_cycle = 2 * len(load) / (len(sizes) + 1)
        # largest difference of sizes by noise, four standard deviations, over the median size
        range_by_noise = (
            _RANGE_OF_NOISE * row_noise(values) / (median_size * math.sqrt(rows_per_cycle))
        )
        relative_sizes = sizes / median_size - 1
        # sizes that are alike differ by less than 3 %
        if float(np.ptp(relative_sizes)) < _LEAST_DIFFERENCE_OF_SIZES + range_by_noise:
            continue
        # from each size to the next one, half a cycle later
        growths = np.diff(relative_sizes)
        extent_words = (
            f"{name} of one cycle goes up and down by {100 * float(np.ptp(relative_sizes)):.2g} %"
            " more than of another"
        )
        if np.all(growths > 0):
            return f"its cycles grow: {extent_words}"
        if np.all(growths < 0):
            return f"its cycles shrink: {extent_words}"
        # growth of one cycle and shrinking of the next, by turns
        is_alternating = float(growths[2:] @ growths[:-2]) < 0
        if len(growths) > _FEWEST_STEPS_OF_PERIOD and is_alternating:
            return f"its period is another, every second cycle is alike: {extent_words}"
        return f"its cycles differ: {extent_words}"
    # neither shows a difference alone: both together may
    return _growth_through_noise(displacement, load, time, load_noise)


def _growth_through_noise(displacement: Array, load: Array, time: Array, load_noise: float) -> str:
    """How the cycles of a measured loop grow or shrink, in words, where the trends of U and Q
    together are beyond their noise though neither is alone; "" where they are not. `load_noise` is
    the standard deviation of Q.

    The trend is the growth of the size of a cycle over the median size, in each cycle; a size is
    the standard deviation of U or Q through it.

    # notation: Q tangential load, U relative tangential displacement
    """
    # rate, with its standard error; None for fewer than two sizes
    trends = [trend_of_sizes(values, load, time, load_noise) for values in (load, displacement)]
    known_trends = [trend for trend in trends if trend is not None]
    if not known_trends:
        return ""
    largest_trend = max(known_trends, key=lambda trend: abs(trend.rate))
    sum_of_squared_ratios = sum((trend.rate / trend.error) ** 2 for trend in known_trends)
    n_cycles = len(sizes_of_cycles(load, load, time, load_noise)) / 2
    # the limit 11, which chance exceeds in 0.4 % of loops
    if sum_of_squared_ratios < _SQUARES_OF_CERTAIN_TRENDS:
        return ""
    # growth over all cycles by less than 3 %
    if abs(largest_trend.rate) * n_cycles < _LEAST_DIFFERENCE_OF_SIZES:
        return ""
    verb = "grow" if largest_trend.rate > 0 else "shrink"
    return (
        f"its cycles {verb}, by {100 * abs(largest_trend.rate):.2g} % in each: U and Q together"
        " show it through their noise"
    )
