"""Measured loads: what reduction and noise make of the dissipation, cycles counted by rainflow, the
dissipation of each of them.

# notation: P, Q loads; W dissipation; sigma standard deviation of the noise of a row
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from reports.comparison.pairs import engine_in_words
from reports.record_parts import parts_in_words, rows_of_turns
from reports.units import energy_unit, load_unit, minus, number
from scenes import ContactSolution, InputError, Scene, TimeSeriesLoad
from scenes.array_types import Array
from scenes.measured import ReadAs, means_of_neighbours

# Of W: a change that is worth a warning.
_LARGEST_CHANGE_WITHOUT_WARNING = 0.01
# Rows beyond which W of other reductions is not computed: half-plane theory takes a second for
# 100,000.
_MOST_ROWS_FOR_WORK = 200_000
# Sigma by second differences over sigma by fourth ones. It is 1 for white noise, far more for
# anything smooth.
_LEAST_SIGMA_RATIO = 0.7
_MOST_SIGMA_RATIO = 1.4
# The error of predicting a row from rows before it, over sigma: noise cannot be predicted.
_LEAST_PREDICTION_ERROR = 0.7
# Fewer rows tell noise from loads by chance; so many of the first show what there is, predicted
# from so many rows before each.
_FEWEST_ROWS_WITH_NOISE = 50
_MOST_PREDICTED_ROWS = 20_000
_N_PREDICTING_ROWS = 8
# Range of means over that of the rows: W grows as its third power, faster near gross sliding, and
# changes by some tenths of a per cent.
_LEAST_RANGE_RATIO_OF_MEANS = 0.999
# Cycles and instants in files, cycles on a page.
_MOST_LISTED_CYCLES = 1000
_MOST_LISTED_INSTANTS = 400
_MOST_SHOWN_CYCLES = 10
# Keys of a record of loads by which no row is left out.
_NO_REDUCTION: dict[str, Any] = {"reduce": None, "threshold": None}
# Columns of rows: time, P, Q.
_TIME, _NORMAL, _TANGENTIAL = range(3)


# ------------------------------------------------------------------------------ reduction and noise
@dataclass(frozen=True)
class RecordCheck:
    """What averaging, reduction and noise of a measured record change in its dissipation W.

    Attributes
    ----------
    n_rows, n_path_rows
        number of rows of the record, and of those that the load path goes through
    work_of_path
        W of the load path by half-plane theory, [energy per thickness] like all W; None, like all
        W, where it was not needed or could not be computed
    work_without_reduction
        W of all rows, or of the means of rows that `load.average` asks for
    work_of_all_rows
        W of all rows, without averaging and reduction
    work_at_half_threshold
        W of the load path with half the threshold for a turning point
    noise
        standard deviation of the noise in P and in Q [load]; 0 where none is seen
    rows_per_mean
        over how many rows a mean may be taken before it blurs the loads
    work_of_means
        W of all rows in means over `rows_per_mean` rows
    """

    n_rows: int
    n_path_rows: int
    work_of_path: float | None
    work_without_reduction: float | None
    work_of_all_rows: float | None
    work_at_half_threshold: float | None
    noise: tuple[float, float]
    rows_per_mean: int
    work_of_means: float | None

    @property
    def noise_share(self) -> float | None:
        """What noise adds to W, over W without it, at least; None where no noise is seen, or one
        of the two W is not known.
        """
        if not (self.work_of_all_rows and self.work_of_means):
            return None
        return self.work_of_all_rows / self.work_of_means - 1


def check_record(scene: Scene) -> RecordCheck | None:
    """The noise of a measured record of loads, and its dissipation W by half-plane theory with and
    without averaging, reduction and noise. None for other loads.

    Reduction leaves out rows between turning points of P or Q, or within a threshold of the path.
    Every W is None for records that repeat or have more than 200,000 rows.
    """
    load_record = scene.load
    if not isinstance(load_record, TimeSeriesLoad):
        return None
    rows = load_record.used_rows().values
    # Standard deviation of the noise of P and of Q; 0 where none is seen.
    # _NORMAL, _TANGENTIAL: columns of P and of Q
    sigmas_of_loads = (sigma_of_noise(rows[:, _NORMAL]), sigma_of_noise(rows[:, _TANGENTIAL]))
    record_check = RecordCheck(
        n_rows=len(rows),
        # rows that the load path goes through, after averaging and reduction
        n_path_rows=len(load_record.kept_rows()),
        work_of_path=None,
        work_without_reduction=None,
        work_of_all_rows=None,
        work_at_half_threshold=None,
        noise=sigmas_of_loads,
        rows_per_mean=1,
        work_of_means=None,
    )
    # _MOST_ROWS_FOR_WORK: 200,000 rows
    if len(rows) > _MOST_ROWS_FOR_WORK or load_record.repeats:
        return record_check
    record_check = _with_works_by_reduction(record_check, scene, load_record)
    # W of means over several rows, which remove noise.
    rows_per_mean = _most_rows_per_mean(rows, sigmas_of_loads) if any(sigmas_of_loads) else 1
    if rows_per_mean == 1:
        return record_check
    work_of_means = _work_of_record(scene, average=rows_per_mean, **_NO_REDUCTION)
    return replace(record_check, rows_per_mean=rows_per_mean, work_of_means=work_of_means)


def _with_works_by_reduction(
    record_check: RecordCheck, scene: Scene, load_record: TimeSeriesLoad
) -> RecordCheck:
    """The check of a record with W of its load path, W without reduction, W of all rows without
    averaging either, and W with half the threshold where it has one.

    `load_record.average` is the number of rows of one mean, 1 for none; `reduce` the kind of
    reduction, None for none; `threshold` its limits in P and Q, None for none.
    """
    work_of_path = _work_of_record(scene)
    work_without_reduction = work_of_path
    if load_record.reduce is not None:
        work_without_reduction = _work_of_record(scene, **_NO_REDUCTION)
    work_of_all_rows = work_without_reduction
    if load_record.average != 1:
        work_of_all_rows = _work_of_record(scene, average=1, **_NO_REDUCTION)
    work_at_half_threshold = None
    threshold = load_record.threshold
    if threshold is not None and max(threshold.P, threshold.Q) > 0:
        half_thresholds = {"P": threshold.P / 2, "Q": threshold.Q / 2}
        work_at_half_threshold = _work_of_record(scene, threshold=half_thresholds)
    return replace(
        record_check,
        work_of_path=work_of_path,
        work_without_reduction=work_without_reduction,
        work_of_all_rows=work_of_all_rows,
        work_at_half_threshold=work_at_half_threshold,
    )


def _work_of_record(scene: Scene, **changes: Any) -> float | None:
    """Dissipation W of a record of loads by half-plane theory, with `changes` of the load's keys
    (reduce, threshold, average); None where the changed record has no solution.
    """
    import semi_analytic

    try:
        changed_scene = scene.vary(load=changes) if changes else scene
        first_and_last_time = changed_scene.load.series()[[0, -1], 0]  # type: ignore[union-attr]
        # Two instants and one place are enough: W needs no fields.
        return semi_analytic.solve(
            changed_scene, x=[0.0], time=first_and_last_time, fields=("dissipation",)
        ).dissipation
    except InputError:
        return None


def sigma_of_noise(values: Array) -> float:
    """Standard deviation sigma of white noise in the values of rows, (n,), from the median of the
    fourth differences of the first 20,000; 0 where no noise shows, or of fewer than 50 rows.

    White noise has second differences of variance 6 sigma^2 and fourth ones of 70 sigma^2, so both
    give one sigma: their ratio must lie between 0.7 and 1.4. Of a load with many rows a period the
    fourth differences are far smaller. A load with few rows a period can be predicted from the
    eight rows before, linearly; noise cannot: the error must be above 0.7 sigma.

    >>> t = np.linspace(0, 20, 2000)
    >>> (
    ...     sigma_of_noise(np.sin(t)),
    ...     round(sigma_of_noise(np.sin(t) + np.random.default_rng(1).normal(0, 0.1, 2000)), 2),
    ... )
    (0.0, 0.1)
    """
    values = values[:_MOST_PREDICTED_ROWS]
    # _FEWEST_ROWS_WITH_NOISE: 50 rows
    if len(values) < _FEWEST_ROWS_WITH_NOISE:
        return 0.0
    # Second differences of white noise have the variance 6 sigma^2, fourth ones 70 sigma^2.
    sigma_by_second_differences = _sigma_of_differences(values, 2, 6)
    sigma_by_fourth_differences = _sigma_of_differences(values, 4, 70)
    # _LEAST_SIGMA_RATIO, _MOST_SIGMA_RATIO: 0.7 and 1.4
    if not (
        sigma_by_fourth_differences > 0
        and _LEAST_SIGMA_RATIO
        < sigma_by_second_differences / sigma_by_fourth_differences
        < _MOST_SIGMA_RATIO
    ):
        return 0.0

    # Predict each value linearly from the eight before it, by least squares.
    # _N_PREDICTING_ROWS: 8 rows before
    windows = np.lib.stride_tricks.sliding_window_view(
        values - np.mean(values), _N_PREDICTING_ROWS + 1
    )
    values_before = windows[:, :-1]
    value_after = windows[:, -1]
    weights = np.linalg.lstsq(values_before, value_after, rcond=None)[0]
    prediction_error = float(np.std(value_after - values_before @ weights))
    # _LEAST_PREDICTION_ERROR: 0.7 sigma
    is_noise = prediction_error > _LEAST_PREDICTION_ERROR * sigma_by_fourth_differences
    return sigma_by_fourth_differences if is_noise else 0.0


def _sigma_of_differences(values: Array, order: int, variance: int) -> float:
    """Standard deviation sigma of white noise in values (n,), from the median size of their
    differences of this order, whose variance is `variance` sigma^2.
    """
    median = float(np.median(np.abs(np.diff(values, order))))
    return 1.4826 * median / variance**0.5


def _most_rows_per_mean(rows: Array, sigmas_of_loads: tuple[float, float]) -> int:
    """The largest number of neighbouring rows of a record over which means may be taken to remove
    its noise without blurring the loads. It leaves at least 50 means.

    The means of a noisy load must still show noise. Those of a load without noise must keep its
    range to 0.1 %.

    Parameters
    ----------
    rows
        (n, 3) time, P, Q
    sigmas_of_loads
        standard deviation of the noise of P and of Q; 0 for a load without noise
    """
    # _NORMAL, _TANGENTIAL: columns of P and of Q
    load_columns = (_NORMAL, _TANGENTIAL)
    noisy_columns = [
        column for column, sigma in zip(load_columns, sigmas_of_loads, strict=True) if sigma
    ]
    noiseless_columns = [column for column in load_columns if column not in noisy_columns]
    rows_per_mean = 1
    # _FEWEST_ROWS_WITH_NOISE: 50 rows
    while len(rows) // (rows_per_mean + 1) >= _FEWEST_ROWS_WITH_NOISE:
        # Means of rows_per_mean + 1 neighbouring rows, columns as in `rows`.
        longer_means = means_of_neighbours(rows, rows_per_mean + 1)
        if not all(sigma_of_noise(longer_means[:, column]) for column in noisy_columns):
            break
        # _LEAST_RANGE_RATIO_OF_MEANS: 0.999 of the range of the rows
        if any(
            np.ptp(longer_means[:, column]) < _LEAST_RANGE_RATIO_OF_MEANS * np.ptp(rows[:, column])
            for column in noiseless_columns
        ):
            break
        rows_per_mean += 1
    return rows_per_mean


class Sentence(NamedTuple):
    """A sentence, and whether it is a warning."""

    text: str
    is_warning: bool


def record_in_words(scene: Scene, record_check: RecordCheck) -> Iterator[Sentence]:
    """Sentences on a measured record of loads, each with whether it is a warning: which rows count,
    its parts, and how much reduction, threshold and noise change the dissipation W.

    `record_check` holds the standard deviation of the noise of P and of Q, and W of the load path,
    and of that with half the threshold for a turning point; None where a W is not known.
    `load_record.reduce` is the kind of reduction of the record, None for none.
    """
    load_record = scene.load
    assert isinstance(load_record, TimeSeriesLoad)
    yield from _rows_in_words(scene, load_record)
    # Sentences on the parts of the record, such as rests and blocks of cycles.
    for text in parts_in_words(scene):
        yield Sentence(text, is_warning=False)
    if load_record.reduce is not None:
        yield _reduction_in_words(scene, load_record, record_check)
    if record_check.work_at_half_threshold is not None and record_check.work_of_path:
        relative_change = _relative_change(
            record_check.work_at_half_threshold, record_check.work_of_path
        )
        text = f"With half the threshold W changes by {_per_cent(relative_change)}."
        # _LARGEST_CHANGE_WITHOUT_WARNING: 1 % of W
        yield Sentence(text, abs(relative_change) > _LARGEST_CHANGE_WITHOUT_WARNING)
    if any(record_check.noise):
        yield _noise_in_words(scene, load_record, record_check)


def _relative_change(value: float | None, value_before: float | None) -> float:
    """Relative change from the value before; 0 where either is None, or that before is 0."""
    return value / value_before - 1 if value is not None and value_before else 0.0


def _per_cent(relative_change: float) -> str:
    return minus(f"{100 * relative_change:+.2g} %")


def _rows_in_words(scene: Scene, load_record: TimeSeriesLoad) -> Iterator[Sentence]:
    """Sentences on which rows of a record are used, where not all are: those between the keys start
    and end, or those with at least the normal load `load_record.least_normal_load`.

    None of them is a warning. `load_record.rows` holds time, P and Q of all rows.
    """
    # Numbers, from 0, of the first row used and of the one after the last.
    first_row, row_beyond = load_record.row_bounds()
    if row_beyond - first_row < len(load_record.rows):
        yield Sentence(
            f"Rows {first_row + 1:,} to {row_beyond:,} of {len(load_record.rows):,} count, by the"
            " keys start and end.",
            is_warning=False,
        )
    if load_record.least_normal_load is not None:
        # _NORMAL: column of P
        is_below_least_load = (
            load_record.rows.values[first_row:row_beyond, _NORMAL] < load_record.least_normal_load
        )
        if not np.any(is_below_least_load):
            return
        yield Sentence(
            f"P is below least_normal_load = {number(load_record.least_normal_load)}"
            f" {load_unit(scene)} in"
            f" {np.count_nonzero(is_below_least_load):,} of the rows: Q counts as 0 there. Of these"
            f" the first {int(np.argmin(is_below_least_load)):,} are initial loading at Q = 0.",
            is_warning=False,
        )


def _reduction_in_words(
    scene: Scene, load_record: TimeSeriesLoad, record_check: RecordCheck
) -> Sentence:
    """A sentence on how many rows of a record the load path goes through, and how much W changes by
    leaving out all others; a warning where it changes by more than 1 %.

    `record_check` holds the numbers of rows, `work_of_path` (W of the reduced record) and
    `work_without_reduction`; a W is None where it could not be computed. `load_record.average` is
    the number of rows of one mean, 1 for none.
    """
    path_in_words = (
        f"The path goes through {record_check.n_path_rows:,} of {record_check.n_rows:,} rows"
    )
    rows_in_words = (
        "all of them" if load_record.average == 1 else f"all means of {load_record.average}"
    )
    if record_check.work_of_path is None and record_check.work_without_reduction is None:
        return Sentence(
            f"{path_in_words}; what that changes in W was not computed.", is_warning=False
        )
    if record_check.work_without_reduction is None:
        text = (
            f"{path_in_words}; {rows_in_words} have no solution, so the change of W is not known."
        )
        return Sentence(text, is_warning=True)
    relative_change = _relative_change(
        record_check.work_of_path, record_check.work_without_reduction
    )
    text = (
        f"{path_in_words}: by half-plane theory W = {number(record_check.work_of_path or 0.0)}"
        f" {energy_unit(scene)}, and {number(record_check.work_without_reduction)} with"
        f" {rows_in_words}"
        f" ({_per_cent(relative_change)})."
    )
    # _LARGEST_CHANGE_WITHOUT_WARNING: 1 % of W
    return Sentence(text, abs(relative_change) > _LARGEST_CHANGE_WITHOUT_WARNING)


def _noise_in_words(
    scene: Scene, load_record: TimeSeriesLoad, record_check: RecordCheck
) -> Sentence:
    """A sentence on the noise of a record of loads: its standard deviation, and how much means of
    several rows, which remove it, change the dissipation W.

    It is a warning where they change W by more than 1 % and `load_record.average` (the number of
    rows of one mean, 1 for none) does not ask for them. `record_check` has the standard deviation
    in P and in Q, 0 where none is seen.
    """
    # The loads with noise, in words, and the load without it.
    noisy_loads = []
    noiseless_load = ""
    for name, sigma in zip("PQ", record_check.noise, strict=True):
        if sigma:
            noisy_loads.append(f"{sigma:.2g} {load_unit(scene)} of {name}")
        else:
            noiseless_load = f"; that of {name} does not show beside its changes from row to row"
    noise_in_words = (
        f"The rows look noisy: standard deviation {' and '.join(noisy_loads)}{noiseless_load}"
    )
    if load_record.average > 1:
        sentence_on_means = _effect_of_requested_means(load_record, record_check)
    else:
        sentence_on_means = _effect_of_possible_means(record_check)
    return Sentence(f"{noise_in_words}. {sentence_on_means.text}", sentence_on_means.is_warning)


def _effect_of_requested_means(load_record: TimeSeriesLoad, record_check: RecordCheck) -> Sentence:
    """A sentence on how much the means of rows that a record of loads asks for (`average` is the
    number of rows of one) change the dissipation W; no warning. `record_check` has W of all rows,
    and of these means (`work_without_reduction`).
    """
    relative_change = _relative_change(
        record_check.work_without_reduction, record_check.work_of_all_rows
    )
    cause = ""
    # _LARGEST_CHANGE_WITHOUT_WARNING: 1 % of W
    if abs(relative_change) > _LARGEST_CHANGE_WITHOUT_WARNING:
        cause = (
            ": by noise, or because means of so many rows blur the loads; compare with a"
            " smaller load.average"
        )
    text = (
        f"The means of {load_record.average} rows change W by {_per_cent(relative_change)}{cause}."
    )
    return Sentence(text, is_warning=False)


def _effect_of_possible_means(record_check: RecordCheck) -> Sentence:
    """A sentence on how much means of rows would change the dissipation W of a record that is not
    averaged; a warning where that is more than 1 %. `record_check` has W of all rows, W of means
    over `rows_per_mean` rows, and what noise adds to W, None where it is not known.
    """
    if record_check.noise_share is None:
        text = (
            "How much of W is noise can't be told: there are too few rows a"
            " cycle, or the record repeats."
        )
        return Sentence(text, is_warning=False)
    relative_change = _relative_change(record_check.work_of_means, record_check.work_of_all_rows)
    is_warning = abs(relative_change) > _LARGEST_CHANGE_WITHOUT_WARNING
    cure = f"; load.average = {record_check.rows_per_mean} takes it out" if is_warning else ""
    text = (
        f"Means of {record_check.rows_per_mean} rows change W by"
        f" {_per_cent(relative_change)}{cure}."
    )
    return Sentence(text, is_warning)


# ---------------------------------------------------------------------------- cycles and their work
@dataclass(frozen=True)
class LoadCycle:
    """A cycle of Q that rainflow counts (`count` 1 for a closed one, 0.5 for half of one), from
    `start` to `end`, when it closes; `range` and `mean` are those of Q [load].

    `dissipation` [energy per thickness] is that of its own time, without what closed cycles within
    it dissipate: all of them add up to W.
    """

    count: float
    range: float
    mean: float
    start: float
    end: float
    dissipation: float


@dataclass(frozen=True, eq=False)
class LoadCycles:
    """Cycles of Q in a record of loads, with the dissipation of each.

    Attributes
    ----------
    cycles
        in the order in which they end
    time, cumulative
        (n,) instants, and the dissipation from the first instant to each [energy per thickness]
    last_whole
        the load cycle between the last three turning points of Q, with all its work; None for a
        record that repeats, and where Q turns less often
    """

    cycles: tuple[LoadCycle, ...]
    time: Array
    cumulative: Array
    last_whole: LoadCycle | None = None

    @property
    def counted(self) -> float:
        """Number of cycles; a half cycle counts 0.5."""
        return sum(cycle.count for cycle in self.cycles)

    @property
    def per_cycle(self) -> float:
        """W over the number of cycles; NaN where there is none."""
        if not self.counted:
            return float("nan")
        return float(self.cumulative[-1]) / self.counted

    def content(self) -> dict[str, Any]:
        """The load cycles for JSON: their number, W over it, the last whole cycle, a list of the
        1,000 cycles with most dissipation, and the dissipation since the first instant at up to 400
        instants.

        `counted` is the number of cycles, half cycles counting 0.5. `cumulative` (n,) is the
        dissipation up to each of the instants `time` (n,).
        """
        cycles_by_work = sorted(self.cycles, key=lambda cycle: -cycle.dissipation)
        listed_cycles = cycles_by_work[:_MOST_LISTED_CYCLES]
        listed_indices = np.unique(
            np.linspace(0, len(self.time) - 1, _MOST_LISTED_INSTANTS).astype(int)
        )
        return {
            "method": "rainflow count of Q, ASTM E1049",
            "counted": self.counted,
            "dissipation_per_cycle": self.per_cycle,
            "last_whole_cycle": None if self.last_whole is None else asdict(self.last_whole),
            "not_listed": len(self.cycles) - len(listed_cycles),
            "cycles": [asdict(cycle) for cycle in listed_cycles],
            "cumulative": {
                "time": self.time[listed_indices],
                "dissipation": self.cumulative[listed_indices],
            },
        }


def load_cycles(solution: ContactSolution) -> LoadCycles | None:
    """Cycles of Q in a measured record of loads, by rainflow count, with the dissipation of each;
    and the dissipation since the first instant at each later one.

    None for other loads, for results of other programs, and where the solution does not hold the
    work of each instant. Of a record that repeats, they are counted over one period that begins at
    the largest Q, so that all are closed. Their work is that of the last period solved.

    Parameters
    ----------
    solution
        `engine`: name of the program; `cycle_dissipation`: W of each solved period; `scene.load`:
        the record, with `repeats` where its rows are one period
    """
    load_record = solution.scene.load
    if not isinstance(load_record, TimeSeriesLoad) or solution.engine not in (
        "semi_analytic",
        "halfplane_fe",
    ):
        return None
    rows = load_record.series()  # (n, 3) time, P, Q

    # Rows of the first period, and the time from it to the last period solved.
    shift_to_last_period = 0.0
    if load_record.repeats:
        rows = rows[1:]  # without the unloaded row before the first period
        n_periods_between = len(solution.cycle_dissipation) - 1
        shift_to_last_period = _duration_of_rows(rows) * n_periods_between

    # Instants within the rows, and the dissipation since the first of them, (m,) each.
    times_and_work = _times_and_work_since_first_row(solution, rows, shift_to_last_period)
    if times_and_work is None:
        return None
    time, work_so_far = times_and_work

    # Cycles of Q counted in the rows that were solved, still without their work.
    # _TIME: column of the times
    solved_rows = rows[rows[:, _TIME] <= time[-1] + _time_tolerance(rows)]
    row_cycles = _cycles_of_rows(solved_rows, repeats=load_record.repeats)
    if load_record.repeats:
        cycles = _cycles_of_last_period(
            row_cycles, time, work_so_far, _duration_of_rows(rows), shift_to_last_period
        )
        return LoadCycles(cycles, time + shift_to_last_period, work_so_far)
    cycles = tuple(cycles_with_work(row_cycles, time, work_so_far))
    return LoadCycles(cycles, time, work_so_far, _last_whole_cycle(solved_rows, time, work_so_far))


def _duration_of_rows(rows: Array) -> float:
    """Time from the first to the last of the rows (n, 3: time, P, Q)."""
    return float(rows[-1, _TIME] - rows[0, _TIME])


def _cycles_of_last_period(
    row_cycles: Sequence[LoadCycle],
    time: Array,
    work_so_far: Array,
    period_duration: float,
    shift_to_last_period: float,
) -> tuple[LoadCycle, ...]:
    """Load cycles of a record that repeats, with their work, at the times of the last two periods
    solved. A cycle may end in the period after that in which it starts: both have the same work.

    Parameters
    ----------
    row_cycles
        cycles at the times of the first period and the one after it, without their work
    time, work_so_far
        (m,) instants of the first period, and the dissipation from the first of them to each
    period_duration
        duration of a period
    shift_to_last_period
        time from the first period to the last one solved
    """
    time_of_two_periods = np.concatenate([time, time[1:] + period_duration])
    work_of_two_periods = np.concatenate([work_so_far, work_so_far[1:] + work_so_far[-1]])
    shift_to_last_period_but_one = max(shift_to_last_period - period_duration, 0.0)
    return tuple(
        replace(
            cycle,
            start=cycle.start + shift_to_last_period_but_one,
            end=cycle.end + shift_to_last_period_but_one,
        )
        for cycle in cycles_with_work(row_cycles, time_of_two_periods, work_of_two_periods)
    )


def _time_tolerance(rows: Array) -> float:
    """Difference of two times that counts as round-off, for rows (n, 3: time, P, Q)."""
    return 1e-9 * float(rows[-1, _TIME] - rows[0, _TIME])


def _times_and_work_since_first_row(
    solution: ContactSolution, rows: Array, shift_to_last_period: float
) -> tuple[Array, Array] | None:
    """Times of a solution within those of the rows (n, 3: time, P, Q), (m,), and the dissipation
    from the first of these times to each, (m,). None where the solution does not hold the work of
    each instant.

    Parameters
    ----------
    solution
        by half-plane theory ("semi_analytic") or finite elements: `time` of its instants, and the
        work of the load step up to each under `record.energy`
    rows
        of the first period, where the rows repeat
    shift_to_last_period
        time from that period to the last one solved, whose work counts; 0 for rows that do not
        repeat
    """
    if solution.engine == "semi_analytic":
        # Theory is solved again at the rows and at the ends of their load cycles.
        time, work = _times_and_work_of_steps(solution.scene, rows, shift_to_last_period)
    else:
        time = solution.time - shift_to_last_period
        work = solution.record.energy.get("dissipation", np.empty(0))
    if len(work) != len(time):
        return None
    # _TIME: column of the times
    is_in_rows = time >= rows[0, _TIME] - _time_tolerance(rows)
    if np.count_nonzero(is_in_rows) < 2:
        return None
    work_so_far = np.cumsum(work[is_in_rows])
    work_so_far -= work_so_far[0]
    return time[is_in_rows], work_so_far


def _cycles_of_rows(rows: Array, *, repeats: bool) -> list[LoadCycle]:
    """Load cycles of Q by rainflow count, without their work, in rows (n, 3: time, P, Q). Where the
    rows repeat, a cycle may end in the next period.
    """
    if repeats:
        return _cycles_of_repeating_rows(rows)
    return rainflow_cycles(rows[:, _TIME], rows[:, _TANGENTIAL])


def _cycles_of_repeating_rows(rows: Array) -> list[LoadCycle]:
    """Load cycles of Q by rainflow count, without their work, in rows (n, 3: time, P, Q) that
    repeat.

    They are counted from the largest Q to the largest Q of the next period, so that all are closed.
    A cycle has `count` 1, half a cycle 0.5, and `start` and `end` times.
    """
    # _TANGENTIAL, _TIME: columns of Q and of the time
    row_of_largest_q = int(np.argmax(rows[:, _TANGENTIAL]))
    period_duration = float(rows[-1, _TIME] - rows[0, _TIME])
    shift_by_period = np.array([period_duration, 0.0, 0.0])
    rows_of_next_period = rows[1 : row_of_largest_q + 1] + shift_by_period
    counted_rows = np.concatenate([rows[row_of_largest_q:], rows_of_next_period])
    cycles = rainflow_cycles(counted_rows[:, _TIME], counted_rows[:, _TANGENTIAL])
    # Rainflow counts the largest cycle, between two equal peaks, as two half cycles.
    half_cycles = [cycle for cycle in cycles if cycle.count < 1]
    if len(half_cycles) != 2:
        return cycles
    largest_cycle = replace(half_cycles[0], count=1.0, end=half_cycles[1].end)
    closed_cycles = [cycle for cycle in cycles if cycle.count == 1]
    return sorted([*closed_cycles, largest_cycle], key=lambda cycle: (cycle.end, -cycle.start))


def _last_whole_cycle(rows: Array, time: Array, work_so_far: Array) -> LoadCycle | None:
    """The load cycle between the last three turning points of Q, in rows (n, 3: time, P, Q); None
    where Q turns less often.

    Its dissipation is the increase of `work_so_far` (m,), the dissipation since the first of the
    times `time` (m,).
    """
    # Numbers of the rows at which Q turns.
    # _TANGENTIAL: column of Q
    turning_rows = rows_of_turns(rows[:, _TANGENTIAL])[-3:]
    if len(turning_rows) < 3:
        return None
    times_of_turns, _, tangential_loads_at_turns = rows[turning_rows].T.tolist()
    start_time, _, end_time = times_of_turns
    work_at_start, work_at_end = np.interp([start_time, end_time], time, work_so_far).tolist()
    largest_tangential_load = max(tangential_loads_at_turns)
    least_tangential_load = min(tangential_loads_at_turns)
    return LoadCycle(
        count=1.0,
        range=largest_tangential_load - least_tangential_load,
        mean=(largest_tangential_load + least_tangential_load) / 2,
        start=start_time,
        end=end_time,
        dissipation=work_at_end - work_at_start,
    )


def _times_and_work_of_steps(
    scene: Scene, rows: Array, shift_of_time: float
) -> tuple[Array, Array]:
    """Times of the rows (n, 3: time, P, Q) and of the ends of their load cycles, (m,), and the
    dissipation in the step that ends at each, (m,), by half-plane theory; 0 at the first time.

    A step leads from one of these times to the next. A cycle may end between two rows. A row is
    added there, on the straight line between them: the load path stays the same, and the work needs
    no interpolation. The work is that at times later by `shift_of_time`: in the last period of rows
    that repeat.
    """
    import semi_analytic

    repeats = scene.load.repeats  # type: ignore[union-attr]
    # _TIME, _NORMAL, _TANGENTIAL: columns of time, P and Q
    row_times = rows[:, _TIME]
    ends_between_rows = _cycle_ends_between_rows(rows, repeats=repeats)
    time = np.sort(np.concatenate([row_times, ends_between_rows]))
    normal_load = np.interp(time, row_times, rows[:, _NORMAL])
    tangential_load = np.interp(time, row_times, rows[:, _TANGENTIAL])
    loads_at_times = np.column_stack([time, normal_load, tangential_load])
    scene_with_ends = scene.vary(load=TimeSeriesLoad(rows=loads_at_times, repeats=repeats))
    solution = semi_analytic.solve(
        scene_with_ends, x=[0.0], time=time + shift_of_time, fields=("dissipation",)
    )
    return time, solution.record.energy["dissipation"]


def _cycle_ends_between_rows(rows: Array, *, repeats: bool) -> Array:
    """Times at which load cycles of Q end between two rows of a record, (k,), ascending. An end
    within 1e-9 of the spacing of a row counts as on it, and is left out. Where the rows repeat, an
    end beyond the last row counts a period earlier.

    `rows` (n, 3) are time, P and Q. `repeats`: whether the rows are one period of a record.
    """
    row_times = rows[:, _TIME]
    period_duration = np.ptp(row_times)
    cycle_ends = np.array([cycle.end for cycle in _cycles_of_rows(rows, repeats=repeats)])
    is_in_next_period = cycle_ends > row_times[-1]
    cycle_ends = np.unique(np.where(is_in_next_period, cycle_ends - period_duration, cycle_ends))

    row_after = np.clip(np.searchsorted(row_times, cycle_ends), 1, len(rows) - 1)
    time_to_row_after = np.abs(row_times[row_after] - cycle_ends)
    time_from_row_before = np.abs(cycle_ends - row_times[row_after - 1])
    spacing = row_times[row_after] - row_times[row_after - 1]
    time_to_nearest_row = np.minimum(time_to_row_after, time_from_row_before)
    return np.asarray(cycle_ends[time_to_nearest_row > 1e-9 * spacing])


def rainflow_cycles(time: Array, force: Array) -> list[LoadCycle]:
    """Load cycles of a force (n,), linear between the times (n,), by rainflow count. They are in
    the order in which they end; their dissipation, not known here, is 0.

    A closed cycle (count 1) lasts from its first reversal to when the force is back at the value it
    had there, so that cycles may lie within others. Half cycles (count 0.5) follow each other.
    """
    from rainflow import extract_cycles

    cycles = []
    for force_range, mean_force, count, first_row, last_row in extract_cycles(force.tolist()):
        end_time = float(time[last_row])
        if count == 1:  # a closed cycle
            end_time = _time_of_return(time, force, first_row, last_row)
        cycles.append(
            LoadCycle(count, force_range, mean_force, float(time[first_row]), end_time, 0.0)
        )
    return sorted(cycles, key=lambda cycle: (cycle.end, -cycle.start))


def cycles_with_work(
    cycles: Sequence[LoadCycle], time: Array, work_so_far: Array
) -> Iterator[LoadCycle]:
    """The load cycles, in the order in which they end, with the dissipation of each, without that
    of cycles within it.

    Dissipation is taken from `work_so_far` (m,), the dissipation since the first of the times
    `time` (m,), linear between them. `cycles` have `start` and `end` times.
    """
    # Start, and work with all that lies within, of cycles so far that lie within no other.
    outer_cycles: list[tuple[float, float]] = []
    for cycle in cycles:
        work_at_start, work_at_end = np.interp([cycle.start, cycle.end], time, work_so_far).tolist()
        work = work_at_end - work_at_start
        work_without_inner_cycles = work
        while outer_cycles:
            start_of_last_cycle, work_of_last_cycle = outer_cycles[-1]
            if start_of_last_cycle < cycle.start:
                break
            # it lies within this cycle
            outer_cycles.pop()
            work_without_inner_cycles -= work_of_last_cycle
        outer_cycles.append((cycle.start, work))
        yield replace(cycle, dissipation=work_without_inner_cycles)


def _time_of_return(time: Array, force: Array, first_row: int, last_row: int) -> float:
    """Time at which the force (n,), after the row `last_row`, is again what it was at the row
    `first_row`; linear between the times (n,). The last time where the force never is.

    Rows are searched in blocks, each twice as long as the one before.
    """
    wanted_force = force[first_row]
    direction = np.sign(wanted_force - force[last_row])
    first_searched_row = last_row + 1
    n_searched_rows = 64  # rows that are looked at together
    while first_searched_row < len(force):
        searched_force = force[first_searched_row : first_searched_row + n_searched_rows]
        rows_beyond = np.flatnonzero(direction * (searched_force - wanted_force) >= 0)
        if len(rows_beyond):
            row = first_searched_row + int(rows_beyond[0])
            fraction = (wanted_force - force[row - 1]) / (force[row] - force[row - 1])
            return float(time[row - 1] + fraction * (time[row] - time[row - 1]))
        first_searched_row += n_searched_rows
        n_searched_rows *= 2
    return float(time[-1])


def record_content(scene: Scene) -> dict[str, Any] | None:
    """Content for JSON on measured data: how the files of a scene were read, the check of its
    record of loads, and sentences on it. None where nothing was measured.

    The check holds noise, and the dissipation W with and without reduction and averaging; None for
    other loads.
    """
    tables_read = read_as_by_key(scene)
    record_check = check_record(scene)
    if not tables_read and record_check is None:
        return None
    # `record_check`: numbers of rows, W by half-plane theory with and without reduction, noise.
    numbers: dict[str, Any] | None = None
    sentences: list[str] = []
    if record_check is not None:
        numbers = {
            "rows": record_check.n_rows,
            "kept": record_check.n_path_rows,
            "dissipation": record_check.work_of_path,
            "unreduced": record_check.work_without_reduction,
            "all_rows": record_check.work_of_all_rows,
            "half_threshold": record_check.work_at_half_threshold,
            "noise": record_check.noise,
            "average": record_check.rows_per_mean,
            "averaged": record_check.work_of_means,
            "by_noise": record_check.noise_share,
        }
        sentences = [sentence.text for sentence in record_in_words(scene, record_check)]
    return {"read_as": tables_read, "loads": numbers, "sentences": sentences}


def read_as_by_key(scene: Scene) -> dict[str, ReadAs]:
    """How each file beside the scene was read, by its key: what was found in it, what was stated,
    what was assumed.
    """
    profile = getattr(scene.profile, "fitted", None) or scene.profile
    read_as = {
        "load.file": getattr(scene.load, "read_as", None),
        "profile.file": getattr(profile, "read_as", None),
    }
    return {name: pairs for name, pairs in read_as.items() if pairs}


def page_section(scene: Scene, solutions: Sequence[ContactSolution]) -> dict[str, Any] | None:
    """What the page shows of measured data; None where nothing was measured.

    By the names in the template: "read" how files were read; "said" sentences on the record of
    loads; "cycles" name and load cycles of each solution; "most" indices, from 0, of up to ten load
    cycles of the first solution, those with most dissipation.
    """
    tables_read = read_as_by_key(scene)
    record_check = check_record(scene)
    if not tables_read and record_check is None:
        return None
    cycles_by_engine = []
    for solution in solutions:
        solution_cycles = load_cycles(solution)
        if solution_cycles is not None:
            engine_name = engine_in_words(solution.engine).capitalize()
            cycles_by_engine.append((engine_name, solution_cycles))
    indices_of_most_work: list[int] = []
    if cycles_by_engine:
        _, cycles_of_first_engine = cycles_by_engine[0]
        dissipations = [cycle.dissipation for cycle in cycles_of_first_engine.cycles]
        indices_by_work = sorted(range(len(dissipations)), key=lambda index: -dissipations[index])
        # _MOST_SHOWN_CYCLES: 10 cycles
        indices_of_most_work = indices_by_work[:_MOST_SHOWN_CYCLES]
    return {
        "read": tables_read,
        "said": list(record_in_words(scene, record_check)) if record_check else [],
        "cycles": cycles_by_engine,
        "most": indices_of_most_work,
    }
