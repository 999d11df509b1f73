"""Measured loads: what reduction and noise make of the dissipation, cycles counted by rainflow, the
dissipation of each of them.

# notation: P, Q loads; W dissipation; sigma standard deviation of the noise of a row
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from reports.comparison.pairs import name_of
from reports.record_parts import parts_in_words, turns_of
from reports.units import energy_unit, load_unit, minus, number
from scenes import ContactSolution, InputError, Scene, TimeSeriesLoad
from scenes.array_types import Array
from scenes.measured import ReadAs, means

# Of W: a change that is worth a warning.
_WARNED = 0.01
# Rows beyond which W of other reductions is not computed: half-plane theory takes a second for
# 100,000.
_MOST_ROWS = 200_000
# Differences of the second and of the fourth order of white noise state one sigma; of anything
# smooth the latter are far less.
_LEAST_RATIO = 0.7
_MOST_RATIO = 1.4
# Fewer rows tell noise from loads by chance; so many of the first show what there is, predicted
# from so many rows before each.
_LEAST_ROWS = 50
_PREDICTED = 20_000
_LAGS = 8
# Range of means over that of the rows: W grows as its third power, faster near gross sliding, and
# changes by some tenths of a per cent.
_UNBLURRED = 0.999
# Cycles and instants in files, cycles on a page.
_LISTED = 1000
_INSTANTS = 400
_SHOWN = 10
# Columns of rows: time, P, Q.
_TIME, _NORMAL, _TANGENTIAL = range(3)


# ------------------------------------------------------------------------------ reduction and noise
@dataclass(frozen=True)
class RecordCheck:
    """What reduction and noise make of W, by half-plane theory; None for what was not asked or
    could not be computed.
    """

    # rows, kept: of the record, and those that the path goes through
    rows: int
    kept: int
    # dissipation, unreduced, all_rows, half_threshold: W of the path, of it without reduction, of
    # all rows, with half the threshold
    dissipation: float | None
    unreduced: float | None
    all_rows: float | None
    half_threshold: float | None
    noise: tuple[float, float]  # (sigma of P, sigma of Q), 0 where none is seen
    # average, averaged: how many rows a mean may stand for before it blurs the loads; W of all rows
    # in such means
    average: int
    averaged: float | None

    @property
    def by_noise(self) -> float | None:
        """Share of W that the noise makes at least; None where no noise is seen."""
        return self.all_rows / self.averaged - 1 if self.all_rows and self.averaged else None


def check_record(scene: Scene) -> RecordCheck | None:
    """What averaging, reduction and noise of a measured record of loads change in its dissipation
    W, by half-plane theory: W with each of them, and without. None for other loads.

    Values of W are None for records that repeat or are very long.
    """
    load = scene.load
    if not isinstance(load, TimeSeriesLoad):
        return None
    rows = load.used_rows().values
    n_kept = len(load.kept_rows())
    noise_of_loads = (noise_of(rows[:, _NORMAL]), noise_of(rows[:, _TANGENTIAL]))
    if len(rows) > _MOST_ROWS or load.repeats:
        return RecordCheck(
            rows=len(rows),
            kept=n_kept,
            dissipation=None,
            unreduced=None,
            all_rows=None,
            half_threshold=None,
            noise=noise_of_loads,
            average=1,
            averaged=None,
        )

    all_kept: dict[str, Any] = {"reduce": None, "threshold": None}
    dissipation = _work(scene)
    unreduced_work = dissipation if load.reduce is None else _work(scene, **all_kept)
    work_of_all_rows = unreduced_work if load.average == 1 else _work(scene, average=1, **all_kept)
    work_at_half_threshold = None
    if load.threshold is not None and max(load.threshold.P, load.threshold.Q) > 0:
        half_of_each = {"P": load.threshold.P / 2, "Q": load.threshold.Q / 2}
        work_at_half_threshold = _work(scene, threshold=half_of_each)
    rows_per_mean = 1
    work_of_means = None
    if any(noise_of_loads):
        rows_per_mean = _longest_means(rows, noise_of_loads)
        if rows_per_mean > 1:
            work_of_means = _work(scene, average=rows_per_mean, **all_kept)
    return RecordCheck(
        rows=len(rows),
        kept=n_kept,
        dissipation=dissipation,
        unreduced=unreduced_work,
        all_rows=work_of_all_rows,
        half_threshold=work_at_half_threshold,
        noise=noise_of_loads,
        average=rows_per_mean,
        averaged=work_of_means,
    )


def _work(scene: Scene, **changes: Any) -> float | None:
    """Dissipation W of a record of loads by half-plane theory, with `changes` in the keys of its
    load; None where that has no solution.
    """
    import semi_analytic

    try:
        changed_scene = scene.vary(load=changes) if changes else scene
        ends = changed_scene.load.series()[[0, -1], 0]  # type: ignore[union-attr]
        return semi_analytic.solve(
            changed_scene, x=[0.0], time=ends, fields=("dissipation",)
        ).dissipation
    except InputError:
        return None


def noise_of(values: Array) -> float:
    """Standard deviation of white noise in the values of rows, (n,), from the median of their
    fourth differences; 0 where no noise shows.

    White noise has second differences of variance 6 sigma^2, fourth ones of 70 sigma^2, and can't
    be predicted from the rows before. Of a load that is resolved by its rows the fourth differences
    are far smaller; one of a few rows a period is predicted.

    >>> t = np.linspace(0, 20, 2000)
    >>> (
    ...     noise_of(np.sin(t)),
    ...     round(noise_of(np.sin(t) + np.random.default_rng(1).normal(0, 0.1, 2000)), 2),
    ... )
    (0.0, 0.1)
    """
    values = values[:_PREDICTED]
    if len(values) < _LEAST_ROWS:
        return 0.0
    sigma_of_second = _sigma_of_differences(values, 2, 6)
    sigma_of_fourth = _sigma_of_differences(values, 4, 70)
    if not (sigma_of_fourth > 0 and _LEAST_RATIO < sigma_of_second / sigma_of_fourth < _MOST_RATIO):
        return 0.0
    windows = np.lib.stride_tricks.sliding_window_view(values - np.mean(values), _LAGS + 1)
    values_before = windows[:, :-1]
    value_after = windows[:, -1]
    weights = np.linalg.lstsq(values_before, value_after, rcond=None)[0]
    prediction_error = float(np.std(value_after - values_before @ weights))
    return sigma_of_fourth if prediction_error > _LEAST_RATIO * sigma_of_fourth else 0.0


def _sigma_of_differences(values: Array, order: int, variance: int) -> float:
    """Standard deviation of white noise from the median of differences of an order, whose variance
    is so many sigma^2.
    """
    median = float(np.median(np.abs(np.diff(values, order))))
    return 1.4826 * median / variance**0.5


def _longest_means(rows: Array, sigma: tuple[float, float]) -> int:
    """The largest number of neighbouring rows of a record over which means may be taken to remove
    its noise. `rows` is (n, 3): time, P, Q; `sigma` the standard deviation of the noise of P and of
    Q, 0 for a load without noise.

    The means of a noisy load must still look like noise, and those of a load without noise keep its
    range: they blur nothing.
    """
    loads = (_NORMAL, _TANGENTIAL)
    noisy_columns = [column for column, size in zip(loads, sigma, strict=True) if size]
    clean_columns = [column for column in loads if column not in noisy_columns]
    rows_per_mean = 1
    while len(rows) // (rows_per_mean + 1) >= _LEAST_ROWS:
        longer_means = means(rows, rows_per_mean + 1)
        if not all(noise_of(longer_means[:, column]) for column in noisy_columns):
            break
        if any(
            np.ptp(longer_means[:, column]) < _UNBLURRED * np.ptp(rows[:, column])
            for column in clean_columns
        ):
            break
        rows_per_mean += 1
    return rows_per_mean


class Sentence(NamedTuple):
    """A sentence, and whether it is a warning."""

    text: str
    warns: bool


def record_in_words(scene: Scene, record: RecordCheck) -> Iterator[Sentence]:
    """Sentences on a measured record of loads: which rows count, its parts, and what reduction,
    threshold and noise change in W.
    """
    load = scene.load
    assert isinstance(load, TimeSeriesLoad)
    yield from _rows_in_words(scene, load)
    for text in parts_in_words(scene):
        yield Sentence(text, warns=False)
    if load.reduce is not None:
        yield _reduction_in_words(scene, load, record)
    if record.half_threshold is not None and record.dissipation:
        relative_change = _change(record.half_threshold, record.dissipation)
        text = f"With half the threshold W changes by {_per_cent(relative_change)}."
        yield Sentence(text, abs(relative_change) > _WARNED)
    if any(record.noise):
        yield _noise_in_words(scene, load, record)


def _change(value: float | None, value_before: float | None) -> float:
    """Relative change of a value; 0 where either is unknown."""
    return value / value_before - 1 if value is not None and value_before else 0.0


def _per_cent(share: float) -> str:
    return minus(f"{100 * share:+.2g} %")


def _rows_in_words(scene: Scene, load: TimeSeriesLoad) -> Iterator[Sentence]:
    """Sentences on which rows of a record count, where not all do: by start and end, or by a least
    normal load.
    """
    first_row, row_beyond = load.bounds()
    if row_beyond - first_row < len(load.rows):
        yield Sentence(
            f"Rows {first_row + 1:,} to {row_beyond:,} of {len(load.rows):,} count, by the keys"
            " start and end.",
            warns=False,
        )
    if load.least_normal_load is not None:
        is_below = load.rows.values[first_row:row_beyond, _NORMAL] < load.least_normal_load
        if not np.any(is_below):
            return
        yield Sentence(
            f"P is below least_normal_load = {number(load.least_normal_load)} {load_unit(scene)} in"
            f" {np.count_nonzero(is_below):,} of the rows: Q counts as 0 there. Of these the first"
            f" {int(np.argmin(is_below)):,} are initial loading at Q = 0.",
            warns=False,
        )


def _reduction_in_words(scene: Scene, load: TimeSeriesLoad, record: RecordCheck) -> Sentence:
    """A sentence on how many rows of a record the load path goes through, and what leaving out the
    others changes in W; a warning where that is much.
    """
    rows_in_words = f"The path goes through {record.kept:,} of {record.rows:,} rows"
    unreduced_in_words = "all of them" if load.average == 1 else f"all means of {load.average}"
    if record.dissipation is None and record.unreduced is None:
        return Sentence(f"{rows_in_words}; what that changes in W was not computed.", warns=False)
    if record.unreduced is None:
        text = (
            f"{rows_in_words}; {unreduced_in_words} have no solution, so the change of W is not"
            " known."
        )
        return Sentence(text, warns=True)
    relative_change = _change(record.dissipation, record.unreduced)
    text = (
        f"{rows_in_words}: by half-plane theory W = {number(record.dissipation or 0.0)}"
        f" {energy_unit(scene)}, and {number(record.unreduced)} with {unreduced_in_words}"
        f" ({_per_cent(relative_change)})."
    )
    return Sentence(text, abs(relative_change) > _WARNED)


def _noise_in_words(scene: Scene, load: TimeSeriesLoad, record: RecordCheck) -> Sentence:
    """A sentence on how noisy the rows of a record of loads are, and what that noise changes in the
    dissipation W; a warning where the change is large. `record` holds what was checked of the
    record.
    """
    noisy_loads = []
    quiet_load = ""
    for name, sigma in zip("PQ", record.noise, strict=True):
        if sigma:
            noisy_loads.append(f"{sigma:.2g} {load_unit(scene)} of {name}")
        else:
            quiet_load = f"; that of {name} does not show beside its changes from row to row"
    noise_in_words = (
        f"The rows look noisy: standard deviation {' and '.join(noisy_loads)}{quiet_load}"
    )
    if load.average > 1:
        relative_change = _change(record.unreduced, record.all_rows)
        cause = ""
        if abs(relative_change) > _WARNED:
            cause = (
                ": by noise, or because means of so many rows blur the loads; compare with a"
                " smaller load.average"
            )
        text = (
            f"{noise_in_words}. The means of {load.average} rows change W by"
            f" {_per_cent(relative_change)}{cause}."
        )
        return Sentence(text, warns=False)
    if record.by_noise is None:
        text = (
            f"{noise_in_words}. How much of W is noise can't be told: there are too few rows a"
            " cycle, or the record repeats."
        )
        return Sentence(text, warns=False)
    relative_change = _change(record.averaged, record.all_rows)
    warns = abs(relative_change) > _WARNED
    cure = f"; load.average = {record.average} takes it out" if warns else ""
    text = (
        f"{noise_in_words}. Means of {record.average} rows change W by"
        f" {_per_cent(relative_change)}{cure}."
    )
    return Sentence(text, warns)


# ---------------------------------------------------------------------------- cycles and their work
@dataclass(frozen=True)
class LoadCycle:
    """A cycle of Q that rainflow counts: 1 for a closed one, 0.5 for half of one; `end` is when it
    closes.

    `dissipation` is that of its own time, without what closed cycles within it dissipate: all of
    them add up to W.
    """

    count: float
    range: float
    mean: float
    start: float
    end: float
    dissipation: float


@dataclass(frozen=True, eq=False)
class LoadCycles:
    """Cycles of Q in the order in which they end, and the dissipation so far, (n,) at the times
    (n,).

    `last_whole` lies between the last three turning points of Q, with all its work; None of a
    record that repeats, and where Q turns less often.
    """

    cycles: tuple[LoadCycle, ...]
    time: Array
    cumulative: Array
    last_whole: LoadCycle | None = None

    @property
    def counted(self) -> float:
        """Halves count half."""
        return sum(cycle.count for cycle in self.cycles)

    @property
    def per_cycle(self) -> float:
        """W over the number of cycles; NaN where there is none."""
        return float(self.cumulative[-1]) / self.counted if self.counted else float("nan")

    def content(self) -> dict[str, Any]:
        """The load cycles for JSON. Of many cycles those of most dissipation are listed, of many
        instants some, evenly.
        """
        cycles_listed = sorted(self.cycles, key=lambda cycle: -cycle.dissipation)[:_LISTED]
        instants = np.unique(np.linspace(0, len(self.time) - 1, _INSTANTS).astype(int))
        return {
            "method": "rainflow count of Q, ASTM E1049",
            "counted": self.counted,
            "dissipation_per_cycle": self.per_cycle,
            "last_whole_cycle": None if self.last_whole is None else asdict(self.last_whole),
            "not_listed": len(self.cycles) - len(cycles_listed),
            "cycles": [asdict(cycle) for cycle in cycles_listed],
            "cumulative": {
                "time": self.time[instants],
                "dissipation": self.cumulative[instants],
            },
        }


def load_cycles(solution: ContactSolution) -> LoadCycles | None:
    """Cycles of Q in a measured record, by rainflow count, with the dissipation of each.

    None for other loads, and for results of other programs. Of a record that repeats it is the last
    cycle, counted from where Q is largest, so that all cycles are closed.
    """
    scene = solution.scene
    if not isinstance(scene.load, TimeSeriesLoad) or solution.engine not in (
        "semi_analytic",
        "halfplane_fe",
    ):
        return None
    rows = scene.load.series()
    start_of_last = 0.0  # start of the last cycle of a record that repeats, minus that of the first
    period = 0.0
    if scene.load.repeats:
        rows = rows[1:]  # without the unloaded row before the cycle
        period = float(rows[-1, _TIME] - rows[0, _TIME])
        start_of_last = period * (len(solution.cycle_dissipation) - 1)
    if solution.engine == "semi_analytic":
        time, work = _work_at_rows(scene, rows, start_of_last)
    else:
        time = solution.time - start_of_last
        work = solution.record.energy.get("dissipation", np.empty(0))
    # a solution that does not hold the work of each instant
    if len(work) != len(time):
        return None
    time_tolerance = 1e-9 * (rows[-1, _TIME] - rows[0, _TIME])
    is_in_record = time >= rows[0, _TIME] - time_tolerance
    if np.count_nonzero(is_in_record) < 2:
        return None
    time = time[is_in_record]
    work_so_far = np.cumsum(work[is_in_record])
    work_so_far -= work_so_far[0]
    solved_rows = rows[rows[:, _TIME] <= time[-1] + time_tolerance]
    if scene.load.repeats:
        last_whole_cycle = None
        # the same work in every revolution
        times_of_work = np.concatenate([time, time[1:] + period])
        work_until_times = np.concatenate([work_so_far, work_so_far[1:] + work_so_far[-1]])
        cycle_shift = max(start_of_last - period, 0.0)
    else:
        last_whole_cycle = _last_whole_cycle(solved_rows, time, work_so_far)
        times_of_work = time
        work_until_times = work_so_far
        cycle_shift = 0.0
    row_cycles = _cycles_of_rows(solved_rows, repeats=scene.load.repeats)
    cycles = [
        replace(cycle, start=cycle.start + cycle_shift, end=cycle.end + cycle_shift)
        for cycle in with_work(row_cycles, times_of_work, work_until_times)
    ]
    return LoadCycles(tuple(cycles), time + start_of_last, work_so_far, last_whole_cycle)


def _cycles_of_rows(rows: Array, *, repeats: bool) -> list[LoadCycle]:
    """Cycles of rows (n, 3), without their work; times of those that repeat may lie in the next
    revolution.
    """
    if repeats:
        return _cycles_of_repeating_rows(rows)
    return counted(rows[:, _TIME], rows[:, _TANGENTIAL])


def _cycles_of_repeating_rows(rows: Array) -> list[LoadCycle]:
    """Load cycles of rows (n, 3: time, P, Q) that repeat, counted from the row of the largest Q to
    the same row one period later: all are closed.
    """
    row_of_largest = int(np.argmax(rows[:, _TANGENTIAL]))
    period = float(rows[-1, _TIME] - rows[0, _TIME])
    shift_by_period = np.array([period, 0.0, 0.0])
    rows_later = rows[1 : row_of_largest + 1] + shift_by_period
    rows_in_turn = np.concatenate([rows[row_of_largest:], rows_later])
    cycles = counted(rows_in_turn[:, _TIME], rows_in_turn[:, _TANGENTIAL])
    # Between two equal peaks the largest swing is counted as its two halves.
    half_cycles = [cycle for cycle in cycles if cycle.count < 1]
    if len(half_cycles) != 2:
        return cycles
    largest_cycle = replace(half_cycles[0], count=1.0, end=half_cycles[1].end)
    closed_cycles = [cycle for cycle in cycles if cycle.count == 1]
    return sorted([*closed_cycles, largest_cycle], key=lambda cycle: (cycle.end, -cycle.start))


def _last_whole_cycle(rows: Array, time: Array, work_so_far: Array) -> LoadCycle | None:
    """The load cycle between the last three turning points of Q, in rows (n, 3: time, P, Q); None
    where Q turns less often. Its work is taken from the sum `work_so_far` (m,) at the times `time`
    (m,).
    """
    turns = turns_of(rows[:, _TANGENTIAL])[-3:]
    if len(turns) < 3:
        return None
    times, _, loads_at_turns = rows[turns].T.tolist()
    start, _, end = times
    work_at_start, work_at_end = np.interp([start, end], time, work_so_far).tolist()
    largest_load = max(loads_at_turns)
    least_load = min(loads_at_turns)
    return LoadCycle(
        count=1.0,
        range=largest_load - least_load,
        mean=(largest_load + least_load) / 2,
        start=start,
        end=end,
        dissipation=work_at_end - work_at_start,
    )


def _work_at_rows(scene: Scene, rows: Array, shift_of_time: float) -> tuple[Array, Array]:
    """Times of the rows (n, 3: time, P, Q) and of the ends of their load cycles, and the
    dissipation since the time before each, by half-plane theory.

    `shift_of_time` shifts them to the last cycle of a record that repeats. A row more on a straight
    line changes nothing of the path, so that the work between two rows needs no interpolation.
    """
    import semi_analytic

    row_times = rows[:, _TIME]
    repeats = scene.load.repeats  # type: ignore[union-attr]
    cycle_ends = np.array([cycle.end for cycle in _cycles_of_rows(rows, repeats=repeats)])
    cycle_ends = np.unique(
        np.where(cycle_ends > row_times[-1], cycle_ends - np.ptp(row_times), cycle_ends)
    )
    row_after = np.clip(np.searchsorted(row_times, cycle_ends), 1, len(rows) - 1)
    time_to_next_row = np.abs(row_times[row_after] - cycle_ends)
    time_from_last_row = np.abs(cycle_ends - row_times[row_after - 1])
    spacing = row_times[row_after] - row_times[row_after - 1]
    ends_between_rows = cycle_ends[
        np.minimum(time_to_next_row, time_from_last_row) > 1e-9 * spacing
    ]
    time = np.sort(np.concatenate([row_times, ends_between_rows]))
    normal_load = np.interp(time, row_times, rows[:, _NORMAL])
    tangential_load = np.interp(time, row_times, rows[:, _TANGENTIAL])
    loads_at_times = np.column_stack([time, normal_load, tangential_load])
    scene_with_ends = scene.vary(load=TimeSeriesLoad(rows=loads_at_times, repeats=repeats))
    solution = semi_analytic.solve(
        scene_with_ends, x=[0.0], time=time + shift_of_time, fields=("dissipation",)
    )
    return time, solution.record.energy["dissipation"]


def counted(time: Array, force: Array) -> list[LoadCycle]:
    """Load cycles of a force (n,), straight between the times (n,), by rainflow count and without
    their work, in the order in which they end.

    A closed cycle lasts from its first reversal to when the force is back there, so that cycles lie
    within one another in time; halves follow each other.
    """
    from rainflow import extract_cycles

    cycles = []
    for size, mean_force, count, first_row, last_row in extract_cycles(force.tolist()):
        end = float(time[last_row])
        if count == 1:  # a closed cycle
            end = _time_of_return(time, force, first_row, last_row)
        cycles.append(LoadCycle(count, size, mean_force, float(time[first_row]), end, 0.0))
    return sorted(cycles, key=lambda cycle: (cycle.end, -cycle.start))


def with_work(cycles: Sequence[LoadCycle], time: Array, work_so_far: Array) -> Iterator[LoadCycle]:
    """The cycles with the dissipation of each, without that of cycles within it. It comes from the
    sum `work_so_far` (m,) at the times `time` (m,), straight between them.
    """
    open_cycles: list[tuple[float, float]] = []  # start and work; none of them lies in another yet
    for cycle in cycles:
        work_at_start, work_at_end = np.interp([cycle.start, cycle.end], time, work_so_far).tolist()
        work = work_at_end - work_at_start
        work_outside = work
        while open_cycles and open_cycles[-1][0] >= cycle.start:
            _, work_within = open_cycles.pop()
            work_outside -= work_within
        open_cycles.append((cycle.start, work))
        yield replace(cycle, dissipation=work_outside)


def _time_of_return(time: Array, force: Array, first_row: int, last_row: int) -> float:
    """Time at which the force (n,), after the row `last_row`, is again what it was at the row
    `first_row`; straight between rows. The end of the rows where it is never.
    """
    level = force[first_row]
    direction = np.sign(level - force[last_row])
    first_searched = last_row + 1
    rows_searched = 64  # rows that are looked at together
    while first_searched < len(force):
        searched_force = force[first_searched : first_searched + rows_searched]
        rows_beyond = np.flatnonzero(direction * (searched_force - level) >= 0)
        if len(rows_beyond):
            row = first_searched + int(rows_beyond[0])
            share = (level - force[row - 1]) / (force[row] - force[row - 1])
            return float(time[row - 1] + share * (time[row] - time[row - 1]))
        first_searched += rows_searched
        rows_searched *= 2
    return float(time[-1])


def record_content(scene: Scene) -> dict[str, Any] | None:
    """For JSON: how files of a scene were read, and what reduction and noise of its record change
    in W. None where nothing was measured.
    """
    tables_read = read_in_pairs(scene)
    record = check_record(scene)
    if not tables_read and record is None:
        return None
    numbers = None
    sentences: list[str] = []
    if record is not None:
        numbers = asdict(record) | {"by_noise": record.by_noise}
        sentences = [sentence.text for sentence in record_in_words(scene, record)]
    return {"read_as": tables_read, "loads": numbers, "sentences": sentences}


def read_in_pairs(scene: Scene) -> dict[str, ReadAs]:
    """How each file beside the scene was read, by its key: what was found in it, what was stated,
    what was assumed.
    """
    profile = getattr(scene.profile, "fitted", None) or scene.profile
    read_as = {
        "load.file": getattr(scene.load, "read_as", None),
        "profile.file": getattr(profile, "read_as", None),
    }
    return {name: pairs for name, pairs in read_as.items() if pairs}


def section(scene: Scene, solutions: Sequence[ContactSolution]) -> dict[str, Any] | None:
    """What the page shows of measured data: how files were read, sentences on the record of loads,
    and its load cycles by each solution; None where there is none.
    """
    tables_read = read_in_pairs(scene)
    record = check_record(scene)
    if not tables_read and record is None:
        return None
    cycles = []
    for solution in solutions:
        cycles_of_solution = load_cycles(solution)
        if cycles_of_solution is not None:
            cycles.append((name_of(solution.engine).capitalize(), cycles_of_solution))
    rows_of_most_work: list[int] = []
    if cycles:
        _, cycles_of_first = cycles[0]
        dissipations = [cycle.dissipation for cycle in cycles_of_first.cycles]
        numbers_by_work = sorted(range(len(dissipations)), key=lambda number: -dissipations[number])
        rows_of_most_work = numbers_by_work[:_SHOWN]
    return {
        "read": tables_read,
        "said": list(record_in_words(scene, record)) if record else [],
        "cycles": cycles,
        "most": rows_of_most_work,
    }
