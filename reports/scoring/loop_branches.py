"""Rows of a loop of Q over U: turning points of Q, and the branch each row lies on.

A row lies on the rising or on the falling branch between two turning points of Q, whatever the form
of Q over time. Turning points are those between which Q passes a quarter and three quarters of its
range: noise, and small reversals on the way, are none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import InputError
from scenes.array_types import Array

# Levels of Q, as shares of its range, that rows must pass between two turning points: noise turns Q
# more often.
_LOWER_LEVEL = 0.25
_UPPER_LEVEL = 0.75
# Scatter of Q from row to row beyond this share of its amplitude hides the loop; rows of a cycle
# below which turning points can't be told.
_LARGEST_SCATTER_SHARE = 0.15
_FEWEST_ROWS_OF_CYCLE = 8
# Rows on each side of a turning point that two parabolas are fitted to: the fewest that leave a
# residual, and how they grow.
_FEWEST_ROWS_OF_HALF_WINDOW = 3
_GROWTH_OF_WINDOW = 1.5
# Places of the joint of the two parabolas that are tried.
_N_JOINTS = 25
# Residuals of the parabolas over the noise of Q, beyond which the window is too long for parabolas.
_LARGEST_RATIO_TO_NOISE = 1.15
# Variance of two joined parabolas at their joint, times the rows on each side over the variance of
# a row.
_VARIANCE_FACTOR_AT_JOINT = 4.5
# Instants at which the size of a cycle is found: more than rows of a cycle are.
_N_INSTANTS_OF_CYCLE = 600


class TurningPoint(NamedTuple):
    """Q at a turning point, and its standard error."""

    load: float
    standard_error: float


@dataclass(frozen=True, eq=False)
class Branches:
    """Where rows lie on a loop.

    Attributes
    ----------
    cycles_passed
        (n,) number of cycles since a lowest Q, with the share of the branch that Q has passed;
        grows with the rows but for noise
    is_rising
        (n,) whether Q grows along the row's branch
    highest_turn, lowest_turn
        turning points of Q
    load_noise
        sigma of Q, as far as neighbouring rows show it
    """

    cycles_passed: Array
    is_rising: NDArray[np.bool_]
    highest_turn: TurningPoint
    lowest_turn: TurningPoint
    load_noise: float

    @property
    def n_cycles(self) -> float:
        """Number of cycles that the rows cover, with a fraction."""
        return float(self.cycles_passed[-1] - self.cycles_passed[0])


# ----------------------------------------------------------------------------- branches of the rows
def row_noise(values: Array) -> float:
    """Standard deviation of white noise of rows (n,), from the median of their fourth differences,
    of variance 70 sigma^2.

    Of rows without noise it is what a smooth curve leaves in them, which is small.
    """
    return 1.4826 * float(np.median(np.abs(np.diff(values, 4)))) / math.sqrt(70)


def find_branches(
    displacement: Array, load: Array, time: Array, resolution: float, source: str
) -> Branches:
    """Divide a measured loop into its branches: for each row whether it lies on the branch on which
    Q rises, and the number of cycles up to it; with the turning points of Q.

    A crossing is where Q passes the middle of its range. One turning point lies between each two
    crossings. Rows of less than two cycles are laid end to end twice, so that each turning point
    has a crossing on both of its sides.

    Returns `cycles_passed` (n,), the number of cycles since a lowest Q, with the share of the
    branch that Q has passed; `is_rising` (n,); the highest and the lowest turning point; and the
    noise of Q.

    Parameters
    ----------
    displacement, load, time
        relative tangential displacement U, Q and time of the rows, (n,) each; time ascends
    resolution
        step of Q that the digits of the rows resolve
    source
        name of the file, for messages

    Raises
    ------
    InputError
        Where Q does not go up and down, or where the rows cover less than a cycle.

    # notation: Q tangential load
    """
    # standard deviation of Q that neighbouring rows show, at least that of the last digit
    load_noise = max(row_noise(load), resolution / math.sqrt(12))
    extreme_loads = _least_and_largest_load(load, load_noise)
    _refuse_scatter(load, load_noise, extreme_loads, source)
    record = _record_of_two_cycles(displacement, load, time, load_noise, extreme_loads, source)
    _refuse_few_rows(record, source)
    turns = _turns_of_record(record, sum(extreme_loads) / 2, load_noise)
    return _branches_between(turns, load, time, load_noise)


class _Turns(NamedTuple):
    """Turning points of Q in the rows of a measured loop.

    Attributes
    ----------
    times
        (m,) times of the turning points, ascending; highest and lowest ones by turns
    first_is_highest
        whether Q is highest at the first of these times
    highest, lowest
        Q at the highest and at the lowest turning point, in the mean over all cycles
    """

    times: Array
    first_is_highest: bool
    highest: TurningPoint
    lowest: TurningPoint


def _turns_of_record(record: _CyclicRows, middle_load: float, load_noise: float) -> _Turns:
    """The turning points of Q in a record with three crossings or more of the middle of Q's range:
    one between each two crossings, and one beyond the first and the last crossing.

    Parameters
    ----------
    record
        Q and time of the rows; last row before and first row after each crossing, and whether Q
        rises there; `period` of one cycle, where the rows are repeated
    middle_load
        middle of Q's range
    load_noise
        standard deviation of Q

    # notation: Q tangential load
    """
    crossing_times = _crossing_times(
        record.load, record.time, record.rows_before, record.rows_after, middle_load
    )
    # turning points, and their delay: how long after the mean time of the two crossings beside
    # them they come
    highest_turn, delay_of_highest = _mean_turning_point(record, crossing_times, True, load_noise)
    lowest_turn, delay_of_lowest = _mean_turning_point(record, crossing_times, False, load_noise)
    turn_times = _times_of_turns(
        crossing_times, record.rises_at_crossing, delay_of_highest, delay_of_lowest
    )
    # Q falls at the first crossing, and so the turning point before it is a highest one
    first_is_highest = not bool(record.rises_at_crossing[0])
    if record.is_repeated:
        # The two inner turning points of a record that was repeated are known best: they
        # are taken again in the two periods before and after. `turn_times` now begins with a copy
        # of the second turning point, which is of the other kind, highest or lowest.
        turn_times = np.concatenate(
            [turn_times[1:3] + n_periods * record.period for n_periods in range(-2, 3)]
        )
        first_is_highest = not first_is_highest
    return _Turns(turn_times, first_is_highest, highest_turn, lowest_turn)


def _branches_between(turns: _Turns, load: Array, time: Array, load_noise: float) -> Branches:
    """The branch of each row between two turning points of Q, rising or falling, and the number of
    cycles up to the row. `load` and `time` (n,) are Q and time of the rows, `load_noise` is the
    standard deviation of Q.

    # notation: Q tangential load
    """
    branch_number = np.asarray(np.searchsorted(turns.times, time, side="right") - 1)
    begins_at_highest = (branch_number % 2 == 0) == turns.first_is_highest
    # turns.highest.load: highest Q of the loop, without the standard error that goes with it
    load_at_begin = np.where(begins_at_highest, turns.highest.load, turns.lowest.load)
    change_since_begin = np.abs(load - load_at_begin)
    share_of_branch = np.clip(
        change_since_begin / (turns.highest.load - turns.lowest.load), 0.0, 1.0
    )
    # an even number at each lowest turning point; which of them is 0 does not matter
    branches_since_lowest = branch_number + share_of_branch + (1 if turns.first_is_highest else 0)
    return Branches(
        cycles_passed=branches_since_lowest / 2,
        is_rising=~begins_at_highest,
        highest_turn=turns.highest,
        lowest_turn=turns.lowest,
        load_noise=load_noise,
    )


@dataclass(frozen=True, eq=False)
class _CyclicRows:
    """Rows of a loop with three crossings or more of the middle of Q, repeated where needed.

    Attributes
    ----------
    load, time
        (n,) Q and time of the rows
    rows_before, rows_after, rises_at_crossing
        (k,) last row before and first row after each crossing, and whether Q rises there
    period
        length of the cycle in time; infinite where the rows are not repeated
    """

    load: Array
    time: Array
    rows_before: NDArray[np.intp]
    rows_after: NDArray[np.intp]
    rises_at_crossing: NDArray[np.bool_]
    period: float = math.inf

    @property
    def is_repeated(self) -> bool:
        """Whether these are one measured cycle and its copy."""
        return math.isfinite(self.period)


def _refuse_scatter(
    load: Array, load_noise: float, extreme_loads: tuple[float, float], source: str
) -> None:
    """InputError where most of the range of Q (n,) is scatter of the rows, of sigma
    `load_noise`."""
    least_load, largest_load = extreme_loads
    if load_noise > _LARGEST_SCATTER_SHARE * (largest_load - least_load) / 2:
        raise InputError(
            f"{source}: its Q goes up and down to {200 * load_noise / np.ptp(load):.0f} % of its"
            f" amplitude only (limit {100 * _LARGEST_SCATTER_SHARE:.0f} %), the rest is scatter:"
            " give the rows in the order of time, and whole cycles"
        )


def _record_of_two_cycles(
    displacement: Array,
    load: Array,
    time: Array,
    load_noise: float,
    extreme_loads: tuple[float, float],
    source: str,
) -> _CyclicRows:
    """The rows of a measured loop as they are, where they have three crossings of the middle of Q's
    range; else their first cycle, laid end to end twice. With them the crossings: last row before
    and first row after each, and whether Q rises there; and the period of a repeated cycle.

    InputError naming the file, `source`, where the rows cover less than one cycle.

    Parameters
    ----------
    displacement, load, time
        (n,) U, Q and time of the rows
    load_noise
        sigma of Q
    extreme_loads
        least and largest Q, without what noise adds

    # notation: Q tangential load, sigma standard deviation of the noise, U relative tangential
    #           displacement
    """
    rows_before_crossings, rows_after_crossings, rises_at_crossing = _crossings_of_middle(
        load, *extreme_loads
    )
    if len(rows_before_crossings) >= 3:
        return _CyclicRows(
            load, time, rows_before_crossings, rows_after_crossings, rises_at_crossing
        )
    # the row that comes nearest to the first one, a cycle later; None without one
    closing_row = _closing_row(
        displacement, load, rows_before_crossings, rises_at_crossing, load_noise
    )
    if closing_row is None:
        least_load, largest_load = extreme_loads
        # up and down: twice the range makes a cycle
        travel_of_load = np.sum(
            np.abs(np.diff(_loads_at_turns(load, rows_before_crossings, rows_after_crossings)))
        )
        covered_cycles = float(travel_of_load / (2 * (largest_load - least_load)))
        raise InputError(
            f"{source}: its rows cover {covered_cycles:.2g} of a cycle: a loop needs a whole one"
        )
    cyclic_load, cyclic_time, period = _two_equal_cycles(load, time, closing_row)
    return _CyclicRows(
        cyclic_load, cyclic_time, *_crossings_of_middle(cyclic_load, *extreme_loads), period
    )


def _refuse_few_rows(record: _CyclicRows, source: str) -> None:
    """InputError where fewer than eight rows make a cycle of a measured loop, in the mean. Also
    where there are fewer than three crossings of the middle of Q. `record.rows_before` and
    `rows_after` are the last row before and the first row after each crossing.

    # notation: Q tangential load
    """
    n_half_cycles = len(record.rows_before) - 1
    rows_between = record.rows_after[-1] - record.rows_before[0]
    is_too_short = len(record.rows_before) < 3
    if is_too_short or 2 * rows_between / n_half_cycles < _FEWEST_ROWS_OF_CYCLE:
        raise InputError(
            f"{source}: a loop needs at least {_FEWEST_ROWS_OF_CYCLE} rows a cycle, in the order"
            " of time"
        )


def _mean_turning_point(
    record: _CyclicRows, crossing_times: Array, is_top: bool, load_noise: float
) -> tuple[TurningPoint, float]:
    """The highest (`is_top`) or the lowest turning point of Q, in the mean over all of them in the
    record; and how much later it comes than the mean time of the two crossings beside it [time].

    Parameters
    ----------
    record
        Q and time of the rows; whether Q rises at each of its crossings of the middle of Q's range;
        `is_repeated`, whether these are one measured cycle and its copy
    crossing_times
        (k,) times at which Q passes the middle of its range
    load_noise
        sigma of Q

    # notation: Q tangential load, sigma standard deviation of the noise
    """
    mean_times = (crossing_times[1:] + crossing_times[:-1]) / 2
    # after a crossing at which Q rises comes a highest turning point
    has_turning_point = record.rises_at_crossing[:-1] == is_top
    return _turning_point(
        record.load,
        record.time,
        # of each two crossings with such a turning point between: mean time, and time between them
        mean_times[has_turning_point],
        np.diff(crossing_times)[has_turning_point],
        is_top,
        load_noise,
        # copies of each measured turning point
        2 if record.is_repeated else 1,
    )


def _two_equal_cycles(load: Array, time: Array, closing_row: int) -> tuple[Array, Array, float]:
    """The rows of one cycle of a measured loop, laid end to end twice: Q and time of the rows so
    repeated, (m,) each, and the period.

    Where the last row of the cycle repeats the first one, the period ends at its time, and the
    second cycle begins with the second row; else the period is longer by a step of time.

    Parameters
    ----------
    load, time
        (n,) Q and time of the rows
    closing_row
        index of the last row of the cycle

    # notation: Q tangential load
    """
    last_repeats_first = abs(load[closing_row] - load[0]) < 0.5 * float(
        np.median(np.abs(np.diff(load)))
    )
    time_step = 0.0 if last_repeats_first else float(np.median(np.diff(time)))
    period = float(time[closing_row]) - float(time[0]) + time_step
    first_row = 1 if last_repeats_first else 0
    cyclic_load = np.concatenate([load[: closing_row + 1], load[first_row : closing_row + 1]])
    cyclic_time = np.concatenate(
        [time[: closing_row + 1], time[first_row : closing_row + 1] + period]
    )
    return cyclic_load, cyclic_time, period


def _times_of_turns(
    crossing_times: Array,
    rises_at_crossing: NDArray[np.bool_],
    delay_of_highest: float,
    delay_of_lowest: float,
) -> Array:
    """Times of the turning points of Q, ascending, (k + 1,): one between each two crossings, one
    before the first crossing, and one behind the last. A crossing is where Q passes the middle of
    its range.

    Parameters
    ----------
    crossing_times
        (k,) times at which Q passes the middle of its range
    rises_at_crossing
        (k,) whether Q rises there
    delay_of_highest, delay_of_lowest
        how long after the mean time of the two crossings beside it Q is highest, or lowest

    # notation: Q tangential load
    """
    mean_times = (crossing_times[1:] + crossing_times[:-1]) / 2
    # Q is highest between a crossing at which it rises and the next one
    is_highest = rises_at_crossing[:-1]
    # half of the time between two crossings, with Q above the middle of its range (True) or below
    # (False)
    half_time_between = {
        above: float(np.median(np.diff(crossing_times)[is_highest == above])) / 2
        for above in (True, False)
    }
    delay_of_turn = {True: delay_of_highest, False: delay_of_lowest}
    turn_times = mean_times + np.where(is_highest, delay_of_highest, delay_of_lowest)
    rises_at_first = bool(rises_at_crossing[0])
    rises_at_last = bool(rises_at_crossing[-1])
    first_turn_time = (
        crossing_times[0]
        - half_time_between[not rises_at_first]
        + delay_of_turn[not rises_at_first]
    )
    last_turn_time = (
        crossing_times[-1] + half_time_between[rises_at_last] + delay_of_turn[rises_at_last]
    )
    return np.concatenate([[first_turn_time], turn_times, [last_turn_time]])


def _least_and_largest_load(load: Array, load_noise: float) -> tuple[float, float]:
    """Least and largest Q, without what noise (its standard deviation) adds to them where that is
    small beside their difference.
    """
    if not np.ptp(load) > 8 * load_noise:
        return float(load.min()), float(load.max())
    return float(load.min()) + 2 * load_noise, float(load.max()) - 2 * load_noise


def _crossings_of_middle(
    load: Array, least_load: float, largest_load: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
    """The k crossings of the middle of the range of Q, (k,) each: index of the last row in one half
    of the range and of the first row in the other half, and whether Q rises from one to the other.

    Rows between a quarter and three quarters of the range belong to no half, so that noise makes no
    crossing.

    Parameters
    ----------
    load
        (n,) Q of the rows
    least_load, largest_load
        ends of the range of Q

    # notation: Q tangential load
    """
    is_load_low = load < least_load + _LOWER_LEVEL * (largest_load - least_load)
    is_load_high = load > least_load + _UPPER_LEVEL * (largest_load - least_load)
    # rows below a quarter or above three quarters of the range
    rows_beyond_levels = np.flatnonzero(is_load_low | is_load_high)
    is_row_high = is_load_high[rows_beyond_levels]
    # indices among these rows: the next of them lies in the other half
    indices_before_change = np.flatnonzero(is_row_high[1:] != is_row_high[:-1])
    return (
        rows_beyond_levels[indices_before_change],
        rows_beyond_levels[indices_before_change + 1],
        is_row_high[indices_before_change + 1],
    )


def sizes_of_cycles(values: Array, load: Array, time: Array, load_noise: float) -> Array:
    """Size of each of the k cycles of a quantity of a measured loop, such as U: its standard
    deviation over the time of the cycle, (k,), in the units of `values`.

    A cycle runs from one time at which Q passes the middle of its range to the next but one; each
    begins half a cycle after the one before.

    Parameters
    ----------
    values
        (n,) the quantity at the rows
    load, time, load_noise
        tangential load Q (n,), its time, and the standard deviation of its noise

    # notation: U relative tangential displacement
    """
    least_load, largest_load = _least_and_largest_load(load, load_noise)
    middle_load = (least_load + largest_load) / 2
    # last row before and first row after each crossing
    rows_before_crossings, rows_after_crossings, _ = _crossings_of_middle(
        load, least_load, largest_load
    )
    crossing_times = _crossing_times(
        load, time, rows_before_crossings, rows_after_crossings, middle_load
    )
    instants_of_cycles = [
        np.linspace(begin, end, _N_INSTANTS_OF_CYCLE)
        for begin, end in zip(crossing_times[:-2], crossing_times[2:], strict=True)
    ]
    return np.array(
        [float(np.std(np.interp(instants, time, values))) for instants in instants_of_cycles]
    )


def _loads_at_turns(
    load: Array, rows_before_crossings: NDArray[np.intp], rows_after_crossings: NDArray[np.intp]
) -> Array:
    """Q of a measured loop at its first row, at each turning point and at its last row. A turning
    point is the extreme Q of the rows between two crossings, at which Q passes the middle of its
    range. `load` (n,) is Q of the rows. The rows before and after crossings are the last one on one
    side of that middle, and the first one on the other.

    # notation: Q tangential load
    """
    # the rows are divided half-way between the two rows beside each crossing
    dividing_rows = ((rows_before_crossings + rows_after_crossings) // 2 + 1).tolist()
    middle_load = float(load.max() + load.min()) / 2
    loads_between_crossings = [
        load[first_row:row_behind]
        for first_row, row_behind in pairwise([0, *dividing_rows, len(load)])
        if row_behind > first_row
    ]
    extremes = [
        float(loads_between[np.argmax(np.abs(loads_between - middle_load))])
        for loads_between in loads_between_crossings
    ]
    return np.array([load[0], *extremes, load[-1]])


def _closing_row(
    displacement: Array,
    load: Array,
    rows_before_crossings: NDArray[np.intp],
    rises_at_crossing: NDArray[np.bool_],
    load_noise: float,
) -> int | None:
    """Index of the row that closes a cycle of a measured loop: the one nearest to the first row, a
    cycle later on the same branch. None where no row comes that near again.

    Parameters
    ----------
    displacement, load
        (n,) U and Q of the rows
    rows_before_crossings, rises_at_crossing
        (k,) last row before each crossing of the middle of Q, and whether Q rises there
    load_noise
        standard deviation of Q

    # notation: Q tangential load, U relative tangential displacement
    """
    if not len(rows_before_crossings):
        return None
    rows_of_branch = _first_branch_a_cycle_later(
        load, rows_before_crossings, rises_at_crossing, load_noise
    )
    if rows_of_branch is None:
        return None

    # rows of that branch that lie near to the first row
    load_from_first = load[rows_of_branch] - load[0]
    displacement_from_first = displacement[rows_of_branch] - displacement[0]
    largest_load_step = float(np.max(np.abs(np.diff(load))))
    largest_displacement_step = float(np.max(np.abs(np.diff(displacement))))
    # Along the branch U changes with Q, roughly as over the whole loop; across the loop it changes
    # alone.
    distance_across_loop = (
        displacement_from_first - np.ptp(displacement) / np.ptp(load) * load_from_first
    )
    is_near_in_load = np.abs(load_from_first) <= 2 * largest_load_step + 4 * load_noise
    is_near_across_loop = np.abs(distance_across_loop) <= largest_displacement_step + 5 * row_noise(
        displacement
    )
    is_near_first = is_near_in_load & is_near_across_loop
    if not np.any(is_near_first):
        return None
    relative_distance = np.hypot(
        load_from_first / np.ptp(load), displacement_from_first / np.ptp(displacement)
    )
    nearest = np.argmin(np.where(is_near_first, relative_distance, math.inf))
    return int(rows_of_branch.start) + int(nearest)


def _first_branch_a_cycle_later(
    load: Array,
    rows_before_crossings: NDArray[np.intp],
    rises_at_crossing: NDArray[np.bool_],
    load_noise: float,
) -> slice | None:
    """Rows of a measured loop on the branch of the first row, rising or falling, a cycle later. The
    branch begins at the first lowest Q behind a highest one, or the other way round, and ends at
    the next turning point. None where the rows do not reach it.

    Parameters
    ----------
    load
        (n,) Q of the rows
    rows_before_crossings, rises_at_crossing
        (k,) last row before each crossing of the middle of Q, and whether Q rises there; k > 0
    load_noise
        standard deviation of Q

    # notation: Q tangential load
    """
    # runs of neighbouring rows with Q above its middle and below it, by turns
    runs_of_rows = np.split(np.arange(len(load)), rows_before_crossings + 1)
    is_high_at_begin = not bool(rises_at_crossing[0])
    is_rising_at_begin = _rises_at_begin(load, runs_of_rows[0], is_high_at_begin, load_noise)
    index_of_turning_run = 1 if is_rising_at_begin == is_high_at_begin else 2
    if len(runs_of_rows) <= index_of_turning_run:
        return None
    turning_run = runs_of_rows[index_of_turning_run]
    loads_of_run = load[turning_run]
    place_in_run = np.argmin(loads_of_run) if is_rising_at_begin else np.argmax(loads_of_run)
    turning_row = int(turning_run[place_in_run])
    # Behind the next turning point rows lie on the other branch, which is nearer than a step.
    loads_behind_turn = load[turning_row:]
    if is_rising_at_begin:
        rows_to_next_turn = int(np.argmax(loads_behind_turn))
    else:
        rows_to_next_turn = int(np.argmin(loads_behind_turn))
    return slice(turning_row, turning_row + rows_to_next_turn + 1)


def _rises_at_begin(
    load: Array, first_run: NDArray[np.intp], is_high_at_begin: bool, load_noise: float
) -> bool:
    """Whether the first row of a measured loop lies on the branch on which Q rises. Of the rows
    before the first crossing of the middle of Q some go farther from the middle than the first
    one, by four standard deviations, where Q leaves the middle at first.

    Parameters
    ----------
    load
        (n,) Q of the rows
    first_run
        indices of the rows before the first crossing
    is_high_at_begin
        whether these lie above the middle
    load_noise
        standard deviation of Q

    # notation: Q tangential load
    """
    if is_high_at_begin:
        leaves_middle_at_begin = np.max(load[first_run]) > load[0] + 4 * load_noise
    else:
        leaves_middle_at_begin = np.min(load[first_run]) < load[0] - 4 * load_noise
    return bool(leaves_middle_at_begin) == is_high_at_begin


def _crossing_times(
    tangential_load: Array,
    time: Array,
    rows_before: NDArray[np.intp],
    rows_after: NDArray[np.intp],
    middle_load: float,
) -> Array:
    """Times at which the tangential load Q passes the middle of its range, (k,): by the straight
    line fitted to the rows of each crossing, from the last one on one side to the first one beyond.

    Parameters
    ----------
    tangential_load
        (n,) Q of the rows
    time
        (n,) their times
    rows_before, rows_after
        (k,) first and last row of each crossing: Q of the rows between lies near the middle
    middle_load
        the middle of Q's range
    """
    crossing_times = []
    for row_before, row_after in zip(rows_before.tolist(), rows_after.tolist(), strict=True):
        rows = slice(row_before, row_after + 1)
        mean_time = float(np.mean(time[rows]))
        slope, mean_load = np.polyfit(time[rows] - mean_time, tangential_load[rows], 1)
        crossing_time = mean_time + (middle_load - mean_load) / slope if slope else mean_time
        crossing_times.append(
            min(max(float(crossing_time), float(time[row_before])), float(time[row_after]))
        )
    return np.array(crossing_times)


def _turning_point(
    load: Array,
    time: Array,
    mean_times: Array,
    durations: Array,
    is_top: bool,
    load_noise: float,
    n_copies: int,
) -> tuple[TurningPoint, float]:
    """Highest (or lowest) Q with its standard error, in the mean over all cycles. With it comes
    its delay [time]: how long after the mean time of the two crossings beside it Q is highest. A
    crossing is where Q passes the middle of its range. The cycles are laid over each other in time.

    Two parabolas that meet at the turning point are fitted to the rows in a window around it, which
    grows as long as they describe the rows to within the noise. The error is that by noise, and the
    change since the window before. Where no window has such a fit the highest row counts.

    Parameters
    ----------
    load, time
        (n,) Q and time of the rows
    mean_times, durations
        (k,) mean of the times of the two crossings beside each turning point, and time between them
    is_top
        whether Q is largest there
    load_noise
        standard deviation of Q
    n_copies
        how often each measured turning point is in the rows: 2 where one cycle was laid end to end
        twice; copies do not make the error smaller

    # notation: Q tangential load
    """
    sign = 1.0 if is_top else -1.0
    half_duration = float(np.median(durations)) / 2
    begin_rows = np.searchsorted(time, mean_times - half_duration)
    end_rows = np.searchsorted(time, mean_times + half_duration)
    # height: Q, with the other sign at a lowest turning point
    rows_around_top = _RowsAroundTop(
        height=sign * load,
        # -1 and 1 at the crossings beside the nearest of the mean times
        scaled_time=_time_from_nearest(mean_times, time) / half_duration,
        rows_in_half_duration=float(np.mean(end_rows - begin_rows)) / 2,
        noise=load_noise,
    )
    largest_height = rows_around_top.largest_height
    guessed_scaled_time = rows_around_top.guessed_time
    fits = rows_around_top.fits_in_growing_windows(guessed_scaled_time)
    if not fits:
        error_of_row = float(
            load_noise + np.ptp(rows_around_top.height) / rows_around_top.rows_in_half_duration
        )
        turning_point = TurningPoint(sign * largest_height, error_of_row)
        return turning_point, guessed_scaled_time * half_duration
    longest_fit = fits[-1]
    height_by_shorter_window = fits[-2].height if len(fits) > 1 else largest_height
    n_measured_turns = max(len(mean_times) // n_copies, 1)
    n_rows = longest_fit.rows_in_half_window * n_measured_turns
    # variance of two joined parabolas at their joint: 4.5 times that of a row over their number
    error_by_noise = load_noise * math.sqrt(_VARIANCE_FACTOR_AT_JOINT / n_rows)
    error = math.hypot(error_by_noise, longest_fit.height - height_by_shorter_window)
    turning_point = TurningPoint(sign * longest_fit.height, error)
    return turning_point, longest_fit.scaled_time * half_duration


@dataclass(frozen=True, eq=False)
class _RowsAroundTop:
    """Rows of a measured loop around its highest Q, all cycles laid over each other in time; or
    around its lowest Q, with the sign changed.

    Attributes
    ----------
    height
        (n,) Q, or -Q where the lowest Q is sought
    scaled_time
        (n,) time since the nearest mean time of two crossings of the middle of Q, over half of
        the time between them: -1 and 1 at the crossings
    rows_in_half_duration
        number of rows in half of that time, in one cycle
    noise
        standard deviation of Q
    """

    height: Array
    scaled_time: Array
    rows_in_half_duration: float
    noise: float

    @property
    def largest_height(self) -> float:
        """Height of the highest row."""
        return float(np.max(self.height[self._is_between_crossings]))

    @property
    def guessed_time(self) -> float:
        """First guess of the turning point's scaled time: the middle of the rows that are nearly as
        high as any.
        """
        least_height = self.largest_height - 0.05 * np.ptp(self.height) - 2 * self.noise
        is_near_top = self._is_between_crossings & (self.height >= least_height)
        return float(np.median(self.scaled_time[is_near_top]))

    @property
    def _is_between_crossings(self) -> NDArray[np.bool_]:
        """(n,) whether a row lies on the side of the turning point of Q's middle."""
        return np.abs(self.scaled_time) < 1

    def fits_in_growing_windows(self, middle_time: float) -> list[_FitOfTop]:
        """Fits of two parabolas to the rows in longer and longer windows around a scaled time. They
        describe a wave that is round at its turning point as well as one with a vertex.

        A window has 3 rows on each side of its middle at first, and 1.5 times as many each time.
        The last one is that before the residuals of the parabolas exceed 1.15 times the noise, and
        is shorter than half of the time between two crossings.
        """
        fits: list[_FitOfTop] = []
        rows_in_half_window = float(_FEWEST_ROWS_OF_HALF_WINDOW)
        most_rows = max(self.rows_in_half_duration, _FEWEST_ROWS_OF_HALF_WINDOW + 0.5)
        while rows_in_half_window < most_rows:
            half_window = (rows_in_half_window + 0.5) / self.rows_in_half_duration
            is_in_window = np.abs(self.scaled_time - middle_time) <= half_window
            time_in_window = (self.scaled_time[is_in_window] - middle_time) / half_window
            # highest value, its time over half the window, and residual; None for too few rows
            parabolas = _highest_of_two_parabolas(time_in_window, self.height[is_in_window])
            if parabolas is not None:
                top_height, top_time_in_window, residual_rms = parabolas
                # this window is too long for parabolas: the one before counts
                if fits and residual_rms > _LARGEST_RATIO_TO_NOISE * self.noise:
                    break
                top_time = middle_time + top_time_in_window * half_window
                fits.append(_FitOfTop(top_height, top_time, rows_in_half_window))
            rows_in_half_window *= _GROWTH_OF_WINDOW
        return fits


class _FitOfTop(NamedTuple):
    """Two parabolas fitted to the rows in a window around a turning point.

    Attributes
    ----------
    height
        largest value of the parabolas: Q, or -Q of a lowest turning point
    scaled_time
        its time from the middle time of two crossings, over half of the time between them
    rows_in_half_window
        number of rows on each side of the middle of the window, in one cycle
    """

    height: float
    scaled_time: float
    rows_in_half_window: float


def _time_from_nearest(given_times: Array, time: Array) -> Array:
    """Times (n,) counted from the nearest of k times (`given_times`), negative before it.

    >>> _time_from_nearest(np.array([0.0, 10.0]), np.array([-1.0, 4.0, 6.0])).tolist()
    [-1.0, 4.0, -4.0]
    """
    if len(given_times) == 1:
        return np.asarray(time - given_times[0])
    index_after = np.clip(np.searchsorted(given_times, time), 1, len(given_times) - 1)
    time_since_given_before = time - given_times[index_after - 1]
    time_until_given_after = given_times[index_after] - time
    nearest_index = np.where(
        time_since_given_before < time_until_given_after, index_after - 1, index_after
    )
    return np.asarray(time - given_times[nearest_index])


def _highest_of_two_parabolas(x: Array, y: Array) -> tuple[float, float, float] | None:
    """Highest value of two parabolas that meet at one point (their joint), fitted to n points (x,
    y) around a turning point, with x from −1 to 1; then the x of this value, and the root mean
    square of the residuals. None for fewer than seven points.

    The joint is sought among 25 places between −0.5 and 0.5, and the highest value between −0.7 and
    0.7.
    """
    degrees_of_freedom = len(x) - 6
    if degrees_of_freedom < 1:
        return None
    # least sum of squares, joint, coefficients
    best_fit = (math.inf, 0.0, np.zeros(5))
    for joint in np.linspace(-0.5, 0.5, _N_JOINTS):
        x_left_of_joint = np.minimum(x - joint, 0.0)
        x_right_of_joint = np.maximum(x - joint, 0.0)
        # unknowns: value at the joint, then slope and curvature on the left and on the right of
        # it
        columns = np.column_stack(
            [
                np.ones_like(x),
                x_left_of_joint,
                x_left_of_joint**2,
                x_right_of_joint,
                x_right_of_joint**2,
            ]
        )
        coefficients = np.linalg.lstsq(columns, y, rcond=None)[0]
        residuals = y - columns @ coefficients
        sum_of_squares = float(residuals @ residuals)
        if sum_of_squares < best_fit[0]:
            best_fit = (sum_of_squares, float(joint), coefficients)
    sum_of_squares, joint, coefficients = best_fit
    # highest value of the best fit
    x_fine = np.linspace(-0.7, 0.7, 281)
    x_left_of_joint = np.minimum(x_fine - joint, 0.0)
    x_right_of_joint = np.maximum(x_fine - joint, 0.0)
    fitted_values = (
        coefficients[0]
        + coefficients[1] * x_left_of_joint
        + coefficients[2] * x_left_of_joint**2
        + coefficients[3] * x_right_of_joint
        + coefficients[4] * x_right_of_joint**2
    )
    index_of_highest = int(np.argmax(fitted_values))
    return (
        float(fitted_values[index_of_highest]),
        float(x_fine[index_of_highest]),
        math.sqrt(sum_of_squares / degrees_of_freedom),
    )
