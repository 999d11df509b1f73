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
    """The check of a measured record; None for other loads."""
    load = scene.load
    if not isinstance(load, TimeSeriesLoad):
        return None
    rows = load.used_rows().values
    n_kept = len(load.kept_rows())
    noise = (noise_of(rows[:, _NORMAL]), noise_of(rows[:, _TANGENTIAL]))
    if len(rows) > _MOST_ROWS or load.repeats:
        return RecordCheck(len(rows), n_kept, None, None, None, None, noise, 1, None)

    all_kept: dict[str, Any] = {"reduce": None, "threshold": None}
    dissipation = _work(scene)
    unreduced = dissipation if load.reduce is None else _work(scene, **all_kept)
    all_rows = unreduced if load.average == 1 else _work(scene, average=1, **all_kept)
    half_threshold = None
    if load.threshold is not None and max(load.threshold.P, load.threshold.Q) > 0:
        halves = {"P": load.threshold.P / 2, "Q": load.threshold.Q / 2}
        half_threshold = _work(scene, threshold=halves)
    average = 1
    averaged = None
    if any(noise):
        average = _longest_means(rows, noise)
        if average > 1:
            averaged = _work(scene, average=average, **all_kept)
    return RecordCheck(
        len(rows),
        n_kept,
        dissipation,
        unreduced,
        all_rows,
        half_threshold,
        noise,
        average,
        averaged,
    )


def _work(scene: Scene, **changes: Any) -> float | None:
    """W of the record, reduced otherwise; None where that has no solution."""
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
    """Standard deviation of white noise of rows (n,), from the median of their fourth differences;
    0 where none is seen.

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
    fourth = _sigma_of_differences(values, 4, 70)
    if not (fourth > 0 and _LEAST_RATIO < sigma_of_second / fourth < _MOST_RATIO):
        return 0.0
    windows = np.lib.stride_tricks.sliding_window_view(values - np.mean(values), _LAGS + 1)
    values_before = windows[:, :-1]
    value_after = windows[:, -1]
    weights = np.linalg.lstsq(values_before, value_after, rcond=None)[0]
    not_predicted = float(np.std(value_after - values_before @ weights))
    return fourth if not_predicted > _LEAST_RATIO * fourth else 0.0


def _sigma_of_differences(values: Array, order: int, variance: int) -> float:
    """Standard deviation of white noise from the median of differences of an order, whose variance
    is so many sigma^2.
    """
    median = float(np.median(np.abs(np.diff(values, order))))
    return 1.4826 * median / variance**0.5


def _longest_means(rows: Array, sigma: tuple[float, float]) -> int:
    """How many rows (n, 3) a mean may stand for: as long as the means of a noisy load still look
    like noise, and those of a load without noise reach as far, they blur nothing of the loads.
    """
    loads = (_NORMAL, _TANGENTIAL)
    noisy = [column for column, size in zip(loads, sigma, strict=True) if size]
    clean = [column for column in loads if column not in noisy]
    count = 1
    while len(rows) // (count + 1) >= _LEAST_ROWS:
        longer = means(rows, count + 1)
        if not all(noise_of(longer[:, column]) for column in noisy):
            break
        if any(
            np.ptp(longer[:, column]) < _UNBLURRED * np.ptp(rows[:, column]) for column in clean
        ):
            break
        count += 1
    return count


class Sentence(NamedTuple):
    """A sentence, and whether it is a warning."""

    text: str
    warns: bool


def record_in_words(scene: Scene, record: RecordCheck) -> Iterator[Sentence]:
    """What counts of a record, its parts, and what reduction, threshold and noise change in W."""
    load = scene.load
    assert isinstance(load, TimeSeriesLoad)
    yield from _rows_in_words(scene, load)
    for text in parts_in_words(scene):
        yield Sentence(text, warns=False)
    if load.reduce is not None:
        yield _reduction_in_words(scene, load, record)
    if record.half_threshold is not None and record.dissipation:
        share = _change(record.half_threshold, record.dissipation)
        text = f"With half the threshold W changes by {_per_cent(share)}."
        yield Sentence(text, abs(share) > _WARNED)
    if any(record.noise):
        yield _noise_in_words(scene, load, record)


def _change(value: float | None, value_before: float | None) -> float:
    """Relative change of a value; 0 where either is unknown."""
    return value / value_before - 1 if value is not None and value_before else 0.0


def _per_cent(share: float) -> str:
    return minus(f"{100 * share:+.2g} %")


def _rows_in_words(scene: Scene, load: TimeSeriesLoad) -> Iterator[Sentence]:
    """Which rows count, where not all do."""
    first_row, row_beyond = load.bounds()
    if row_beyond - first_row < len(load.rows):
        yield Sentence(
            f"Rows {first_row + 1:,} to {row_beyond:,} of {len(load.rows):,} count, by the keys"
            " start and"
            " end.",
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
    """How many rows the path goes through, and what leaving out the others changes in W."""
    path = f"The path goes through {record.kept:,} of {record.rows:,} rows"
    all_of = "all of them" if load.average == 1 else f"all means of {load.average}"
    if record.dissipation is None and record.unreduced is None:
        return Sentence(f"{path}; what that changes in W was not computed.", warns=False)
    if record.unreduced is None:
        text = f"{path}; {all_of} have no solution, so the change of W is not known."
        return Sentence(text, warns=True)
    share = _change(record.dissipation, record.unreduced)
    text = (
        f"{path}: by half-plane theory W = {number(record.dissipation or 0.0)}"
        f" {energy_unit(scene)}, and {number(record.unreduced)} with {all_of}"
        f" ({_per_cent(share)})."
    )
    return Sentence(text, abs(share) > _WARNED)


def _noise_in_words(scene: Scene, load: TimeSeriesLoad, record: RecordCheck) -> Sentence:
    """How noisy the rows are, and what that makes of W."""
    seen = []
    unseen = ""
    for name, sigma in zip("PQ", record.noise, strict=True):
        if sigma:
            seen.append(f"{sigma:.2g} {load_unit(scene)} of {name}")
        else:
            unseen = f"; that of {name} does not show beside its changes from row to row"
    noise = f"The rows look noisy: standard deviation {' and '.join(seen)}{unseen}"
    if load.average > 1:
        share = _change(record.unreduced, record.all_rows)
        cause = ""
        if abs(share) > _WARNED:
            cause = (
                ": by noise, or because means of so many rows blur the loads; compare with a"
                " smaller load.average"
            )
        text = f"{noise}. The means of {load.average} rows change W by {_per_cent(share)}{cause}."
        return Sentence(text, warns=False)
    if record.by_noise is None:
        text = (
            f"{noise}. How much of W is noise can't be told: there are too few rows a cycle, or the"
            " record repeats."
        )
        return Sentence(text, warns=False)
    share = _change(record.averaged, record.all_rows)
    warns = abs(share) > _WARNED
    cure = f"; load.average = {record.average} takes it out" if warns else ""
    text = f"{noise}. Means of {record.average} rows change W by {_per_cent(share)}{cure}."
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
        """For JSON: of many cycles those of most dissipation, of many instants some, evenly."""
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
    """Cycles of a measured record and the dissipation of each; None for other loads, and for
    results of other programs.

    Of a record that repeats: of its last cycle, counted from where Q is largest, so that all
    cycles are closed.
    """
    scene = solution.scene
    if not isinstance(scene.load, TimeSeriesLoad) or solution.engine not in (
        "semi_analytic",
        "halfplane_fe",
    ):
        return None
    rows = scene.load.series()
    last_start = 0.0  # of the last cycle, after that of the first
    period = 0.0
    if scene.load.repeats:
        rows = rows[1:]
        period = float(rows[-1, _TIME] - rows[0, _TIME])
        last_start = period * (len(solution.cycle_dissipation) - 1)
    if solution.engine == "semi_analytic":
        time, work = _work_at_rows(scene, rows, last_start)
    else:
        time = solution.time - last_start
        work = solution.record.energy.get("dissipation", np.empty(0))
    if len(work) != len(time):
        return None
    slack = 1e-9 * (rows[-1, _TIME] - rows[0, _TIME])
    in_record = time >= rows[0, _TIME] - slack
    if np.count_nonzero(in_record) < 2:
        return None
    time = time[in_record]
    so_far = np.cumsum(work[in_record])
    so_far -= so_far[0]
    solved_rows = rows[rows[:, _TIME] <= time[-1] + slack]
    if scene.load.repeats:
        last_whole = None
        # the same work in every revolution
        work_time = np.concatenate([time, time[1:] + period])
        work_so_far = np.concatenate([so_far, so_far[1:] + so_far[-1]])
        cycle_shift = max(last_start - period, 0.0)
    else:
        last_whole = _last_whole_cycle(solved_rows, time, so_far)
        work_time = time
        work_so_far = so_far
        cycle_shift = 0.0
    row_cycles = _cycles_of_rows(solved_rows, repeats=scene.load.repeats)
    cycles = [
        replace(cycle, start=cycle.start + cycle_shift, end=cycle.end + cycle_shift)
        for cycle in with_work(row_cycles, work_time, work_so_far)
    ]
    return LoadCycles(tuple(cycles), time + last_start, so_far, last_whole)


def _cycles_of_rows(rows: Array, *, repeats: bool) -> list[LoadCycle]:
    """Cycles of rows (n, 3), without their work; times of those that repeat may lie in the next
    revolution.
    """
    if repeats:
        return _counted_in_turn(rows)
    return counted(rows[:, _TIME], rows[:, _TANGENTIAL])


def _counted_in_turn(rows: Array) -> list[LoadCycle]:
    """Cycles of rows (n, 3) that repeat, from the row of the largest Q to the same row a revolution
    later: all are closed.
    """
    start = int(np.argmax(rows[:, _TANGENTIAL]))
    period = float(rows[-1, _TIME] - rows[0, _TIME])
    a_revolution = np.array([period, 0.0, 0.0])
    rows_later = rows[1 : start + 1] + a_revolution
    rows_in_turn = np.concatenate([rows[start:], rows_later])
    cycles = counted(rows_in_turn[:, _TIME], rows_in_turn[:, _TANGENTIAL])
    # Between two equal peaks the largest swing is counted as its two halves.
    halves = [cycle for cycle in cycles if cycle.count < 1]
    if len(halves) != 2:
        return cycles
    whole = replace(halves[0], count=1.0, end=halves[1].end)
    closed = [cycle for cycle in cycles if cycle.count == 1]
    return sorted([*closed, whole], key=lambda cycle: (cycle.end, -cycle.start))


def _last_whole_cycle(rows: Array, time: Array, so_far: Array) -> LoadCycle | None:
    """The cycle between the last three turning points of Q of rows (n, 3), its work from the sum
    (m,) at times (m,); None where Q turns less often.
    """
    turns = turns_of(rows[:, _TANGENTIAL])[-3:]
    if len(turns) < 3:
        return None
    times, _, forces = rows[turns].T.tolist()
    start, _, end = times
    work_at_start, work_at_end = np.interp([start, end], time, so_far).tolist()
    highest = max(forces)
    lowest = min(forces)
    return LoadCycle(
        count=1.0,
        range=highest - lowest,
        mean=(highest + lowest) / 2,
        start=start,
        end=end,
        dissipation=work_at_end - work_at_start,
    )


def _work_at_rows(scene: Scene, rows: Array, late_time: float) -> tuple[Array, Array]:
    """Times of rows (n, 3) and of the ends of their cycles, and W since the time before each, by
    half-plane theory.

    A row more on a straight line changes nothing of the path, so that the work between two rows
    needs no interpolation.
    """
    import semi_analytic

    row_times = rows[:, _TIME]
    repeats = scene.load.repeats  # type: ignore[union-attr]
    ends = np.array([cycle.end for cycle in _cycles_of_rows(rows, repeats=repeats)])
    ends = np.unique(np.where(ends > row_times[-1], ends - np.ptp(row_times), ends))
    row_after = np.clip(np.searchsorted(row_times, ends), 1, len(rows) - 1)
    to_after = np.abs(row_times[row_after] - ends)
    from_before = np.abs(ends - row_times[row_after - 1])
    spacing = row_times[row_after] - row_times[row_after - 1]
    between_rows = ends[np.minimum(to_after, from_before) > 1e-9 * spacing]
    time = np.sort(np.concatenate([row_times, between_rows]))
    normal_load = np.interp(time, row_times, rows[:, _NORMAL])
    tangential_load = np.interp(time, row_times, rows[:, _TANGENTIAL])
    path = np.column_stack([time, normal_load, tangential_load])
    closer = scene.vary(load=TimeSeriesLoad(rows=path, repeats=repeats))
    solution = semi_analytic.solve(closer, x=[0.0], time=time + late_time, fields=("dissipation",))
    return time, solution.record.energy["dissipation"]


def counted(time: Array, force: Array) -> list[LoadCycle]:
    """Cycles of a force (n,), straight between the times (n,), without their work, in the order in
    which they end.

    A closed cycle lasts from its first reversal to when the force is back there, so that cycles lie
    within one another in time; halves follow each other.
    """
    from rainflow import extract_cycles

    cycles = []
    for size, mean, count, first_row, last_row in extract_cycles(force.tolist()):
        end = _back(time, force, first_row, last_row) if count == 1 else float(time[last_row])
        cycles.append(LoadCycle(count, size, mean, float(time[first_row]), end, 0.0))
    return sorted(cycles, key=lambda cycle: (cycle.end, -cycle.start))


def with_work(cycles: Sequence[LoadCycle], time: Array, so_far: Array) -> Iterator[LoadCycle]:
    """The cycles with the work of each, from its sum `so_far` (m,) at times (m,), straight between
    them.
    """
    ended: list[tuple[float, float]] = []  # start and work of cycles that none has taken in yet
    for cycle in cycles:
        at_start, at_end = np.interp([cycle.start, cycle.end], time, so_far).tolist()
        work = at_end - at_start
        work_alone = work
        while ended and ended[-1][0] >= cycle.start:
            _, work_within = ended.pop()
            work_alone -= work_within
        ended.append((cycle.start, work))
        yield replace(cycle, dissipation=work_alone)


def _back(time: Array, force: Array, first_row: int, last_row: int) -> float:
    """When the force, after the row `last_row`, is again what it was at the row `first_row`."""
    level = force[first_row]
    direction = np.sign(level - force[last_row])
    begin = last_row + 1
    count = 64  # rows that are looked at together
    while begin < len(force):
        rows_beyond = np.flatnonzero(direction * (force[begin : begin + count] - level) >= 0)
        if len(rows_beyond):
            row = begin + int(rows_beyond[0])
            share = (level - force[row - 1]) / (force[row] - force[row - 1])
            return float(time[row - 1] + share * (time[row] - time[row - 1]))
        begin += count
        count *= 2
    return float(time[-1])


def record_content(scene: Scene) -> dict[str, Any] | None:
    """For JSON: how files were read, what reduction and noise make of W; None where nothing was
    measured.
    """
    read = read_in_pairs(scene)
    record = check_record(scene)
    if not read and record is None:
        return None
    numbers = None
    sentences: list[str] = []
    if record is not None:
        numbers = asdict(record) | {"by_noise": record.by_noise}
        sentences = [sentence.text for sentence in record_in_words(scene, record)]
    return {"read_as": read, "loads": numbers, "sentences": sentences}


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
    """What the page shows of measured data: how files were read, sentences on the record, its
    cycles; None where there is none.
    """
    read = read_in_pairs(scene)
    record = check_record(scene)
    if not read and record is None:
        return None
    cycles = []
    for solution in solutions:
        of_solution = load_cycles(solution)
        if of_solution is not None:
            cycles.append((name_of(solution.engine).capitalize(), of_solution))
    most: list[int] = []
    if cycles:
        _, of_first = cycles[0]
        dissipations = [cycle.dissipation for cycle in of_first.cycles]
        most = sorted(range(len(dissipations)), key=lambda k: -dissipations[k])[:_SHOWN]
    return {
        "read": read,
        "said": list(record_in_words(scene, record)) if record else [],
        "cycles": cycles,
        "most": most,
    }
