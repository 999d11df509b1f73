"""Measured loads: what reduction and noise make of the dissipation, cycles counted by rainflow, the
dissipation of each of them.

# notation: P, Q loads; W dissipation; sigma standard deviation of the noise of a row
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.comparison.pairs import name_of
from reports.units import energy_unit, load_unit, minus, number
from scenes import ContactSolution, InputError, Scene, TimeSeriesLoad
from scenes.measured import ReadAs, means

Array = NDArray[np.float64]

# Of W: a change that is worth a warning.
_WARNED = 0.01
# Rows beyond which W of other reductions is not computed: half-plane theory takes a second for
# 100,000.
_MOST_ROWS = 200_000
# Differences of the second and of the fourth order of white noise state one sigma; of anything
# smooth the latter are far less.
_ALIKE = (0.7, 1.4)
# Fewer rows tell noise from loads by chance; so many of the first show what there is, predicted
# from so many rows before each.
_LEAST_ROWS, _PREDICTED, _LAGS = 50, 20_000, 8
# Cycles and instants in files, cycles on a page.
_LISTED, _INSTANTS, _SHOWN = 1000, 400, 10


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
    rows, kept = load.used_rows().values, len(load.kept_rows())
    sigma = (noise_of(rows[:, 1]), noise_of(rows[:, 2]))
    if len(rows) > _MOST_ROWS or load.repeats:
        return RecordCheck(len(rows), kept, None, None, None, None, sigma, 1, None)
    whole, half, average, averaged = {"reduce": None, "threshold": None}, None, 1, None
    own = _work(scene)
    unreduced = own if load.reduce is None else _work(scene, **whole)
    every = unreduced if load.average == 1 else _work(scene, average=1, **whole)
    if load.threshold is not None and max(load.threshold.P, load.threshold.Q) > 0:
        half = _work(scene, threshold={"P": load.threshold.P / 2, "Q": load.threshold.Q / 2})
    if any(sigma):
        average = _longest_means(rows, sigma)
        averaged = _work(scene, average=average, **whole) if average > 1 else None
    return RecordCheck(len(rows), kept, own, unreduced, every, half, sigma, average, averaged)


def _work(scene: Scene, **changes: Any) -> float | None:
    """W of the record, reduced otherwise; None where that has no solution."""
    import semi_analytic

    try:
        other = scene.vary(load=changes) if changes else scene
        ends = other.load.series()[[0, -1], 0]  # type: ignore[union-attr]
        return semi_analytic.solve(other, x=[0.0], time=ends, fields=("dissipation",)).dissipation
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
    second, fourth = (
        1.4826 * float(np.median(np.abs(np.diff(values, k)))) / n**0.5 for k, n in ((2, 6), (4, 70))
    )
    if not (fourth > 0 and _ALIKE[0] < second / fourth < _ALIKE[1]):
        return 0.0
    before = np.lib.stride_tricks.sliding_window_view(values - np.mean(values), _LAGS + 1)
    weights = np.linalg.lstsq(before[:, :-1], before[:, -1], rcond=None)[0]
    missed = float(np.std(before[:, -1] - before[:, :-1] @ weights))
    return fourth if missed > _ALIKE[0] * fourth else 0.0


def _longest_means(rows: Array, sigma: tuple[float, float]) -> int:
    """How many rows (n, 3) a mean may stand for: as long as the means still look like noise, they
    blur nothing of the loads.
    """
    count = 1
    while len(rows) // (count + 1) >= _LEAST_ROWS:
        blurred = means(rows, count + 1)
        if not all(
            noise_of(blurred[:, column]) for column, size in zip((1, 2), sigma, strict=True) if size
        ):
            break
        count += 1
    return count


def record_in_words(scene: Scene, found: RecordCheck) -> Iterator[tuple[str, bool]]:
    """Sentences, and whether each is a warning."""
    load, unit, energy = scene.load, load_unit(scene), energy_unit(scene)
    assert isinstance(load, TimeSeriesLoad)

    def change(value: float | None, before: float | None) -> tuple[str, bool]:
        """In per cent, and whether it is worth a warning."""
        share = value / before - 1 if value is not None and before else 0.0
        return minus(f"{100 * share:+.2g} %"), abs(share) > _WARNED

    first, beyond = load.bounds()
    if beyond - first < len(load.rows):
        yield (
            (
                f"Rows {first + 1:,} to {beyond:,} of {len(load.rows):,} count, by the keys start"
                " and end."
            ),
            False,
        )
    if load.least_normal_load is not None:
        low = load.rows.values[first:beyond, 1] < load.least_normal_load
        yield (
            (
                f"P is below least_normal_load = {number(load.least_normal_load)} {unit} in"
                f" {np.count_nonzero(low):,} of the rows: Q counts as 0 there. Of these the first"
                f" {int(np.argmin(low)):,} are initial loading at Q = 0."
            ),
            False,
        )
    if load.reduce is not None:
        words = f"The path goes through {found.kept:,} of {found.rows:,} rows"
        all_of = "all of them" if load.average == 1 else f"all means of {load.average}"
        if found.dissipation is None and found.unreduced is None:
            yield f"{words}; what that changes in W was not computed.", False
        elif found.unreduced is None:
            yield f"{words}; {all_of} have no solution, so the change of W is not known.", True
        else:
            by, much = change(found.dissipation, found.unreduced)
            yield (
                (
                    f"{words}: by half-plane theory W = {number(found.dissipation or 0.0)}"
                    f" {energy}, and {number(found.unreduced)} with {all_of} ({by})."
                ),
                much,
            )
    if found.half_threshold is not None and found.dissipation:
        by, much = change(found.half_threshold, found.dissipation)
        yield f"With half the threshold W changes by {by}.", much
    if any(found.noise):
        seen = (
            f"The rows look noisy: standard deviation {found.noise[0]:.2g} of P and"
            f" {found.noise[1]:.2g} {unit} of Q"
        )
        if load.average > 1:
            by, much = change(found.unreduced, found.all_rows)
            doubt = (
                ": by noise, or because means of so many rows blur the loads; compare with a"
                " smaller load.average" * much
            )
            yield f"{seen}. The means of {load.average} rows change W by {by}{doubt}.", False
        elif found.by_noise is None:
            yield (
                (
                    f"{seen}. How much of W is noise can't be told: there are too few rows a cycle,"
                    " or the record repeats."
                ),
                False,
            )
        else:
            by, much = change(found.averaged, found.all_rows)
            cure = f"; load.average = {found.average} takes it out" if much else ""
            yield f"{seen}. Means of {found.average} rows change W by {by}{cure}.", much


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
    """

    cycles: tuple[LoadCycle, ...]
    time: Array
    cumulative: Array

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
        most = sorted(self.cycles, key=lambda cycle: -cycle.dissipation)[:_LISTED]
        some = np.unique(np.linspace(0, len(self.time) - 1, _INSTANTS).astype(int))
        return {
            "method": "rainflow count of Q, ASTM E1049",
            "counted": self.counted,
            "dissipation_per_cycle": self.per_cycle,
            "not_listed": len(self.cycles) - len(most),
            "cycles": [asdict(cycle) for cycle in most],
            "cumulative": {"time": self.time[some], "dissipation": self.cumulative[some]},
        }


def load_cycles(solution: ContactSolution) -> LoadCycles | None:
    """Cycles of a measured record and the dissipation of each; None for other loads, and for
    results of other programs.

    Of a record that repeats: of its last cycle.
    """
    scene = solution.scene
    if not isinstance(scene.load, TimeSeriesLoad) or solution.engine not in (
        "semi_analytic",
        "halfplane_fe",
    ):
        return None
    rows = scene.load.series()
    late = 0.0
    if scene.load.repeats:
        rows = rows[1:]
        late = (rows[-1, 0] - rows[0, 0]) * (len(solution.cycle_dissipation) - 1)
    time, work = solution.time - late, solution.record.energy.get("dissipation", np.empty(0))
    if solution.engine == "semi_analytic":
        time, work = _work_at_rows(scene, rows, late)
    slack = 1e-9 * (rows[-1, 0] - rows[0, 0])
    if len(work) != len(time) or np.count_nonzero(inside := time >= rows[0, 0] - slack) < 2:
        return None
    time, so_far = time[inside], np.cumsum(work[inside])
    so_far -= so_far[0]
    solved = rows[rows[:, 0] <= time[-1] + slack]
    cycles = tuple(with_work(counted(solved[:, 0], solved[:, 2]), time, so_far))
    return LoadCycles(
        tuple(replace(one, start=one.start + late, end=one.end + late) for one in cycles),
        time + late,
        so_far,
    )


def _work_at_rows(scene: Scene, rows: Array, late: float) -> tuple[Array, Array]:
    """Times of rows (n, 3) and of the ends of their cycles, and W since the time before each, by
    half-plane theory.

    A row more on a straight line changes nothing of the path, so that the work between two rows
    needs no interpolation.
    """
    import semi_analytic

    ends = np.unique([cycle.end for cycle in counted(rows[:, 0], rows[:, 2])])
    after = np.clip(np.searchsorted(rows[:, 0], ends), 1, len(rows) - 1)
    apart = np.minimum(np.abs(rows[after, 0] - ends), np.abs(ends - rows[after - 1, 0]))
    time = np.sort(
        np.concatenate([rows[:, 0], ends[apart > 1e-9 * (rows[after, 0] - rows[after - 1, 0])]])
    )
    path = np.column_stack([time, *(np.interp(time, rows[:, 0], rows[:, k]) for k in (1, 2))])
    closer = scene.vary(load=TimeSeriesLoad(rows=path, repeats=scene.load.repeats))  # type: ignore[union-attr]
    found = semi_analytic.solve(closer, x=[0.0], time=time + late, fields=("dissipation",))
    return time, found.record.energy["dissipation"]


def counted(time: Array, force: Array) -> list[LoadCycle]:
    """Cycles of a force (n,), straight between the times (n,), without their work, in the order in
    which they end.

    A closed cycle lasts from its first reversal to when the force is back there, so that cycles lie
    within one another in time; halves follow each other.
    """
    from rainflow import extract_cycles

    found = []
    for size, mean, count, first, last in extract_cycles(force.tolist()):
        end = _back(time, force, first, last) if count == 1 else float(time[last])
        found.append(LoadCycle(count, size, mean, float(time[first]), end, 0.0))
    return sorted(found, key=lambda cycle: (cycle.end, -cycle.start))


def with_work(cycles: Sequence[LoadCycle], time: Array, so_far: Array) -> Iterator[LoadCycle]:
    """The cycles with the work of each, from its sum `so_far` (m,) at times (m,), straight between
    them.
    """
    ended: list[tuple[float, float]] = []  # start and work of cycles that none has taken in yet
    for cycle in cycles:
        whole = float(np.interp(cycle.end, time, so_far) - np.interp(cycle.start, time, so_far))
        own = whole
        while ended and ended[-1][0] >= cycle.start:
            own -= ended.pop()[1]
        ended.append((cycle.start, whole))
        yield replace(cycle, dissipation=own)


def _back(time: Array, force: Array, first: int, last: int) -> float:
    """When the force, after the row `last`, is again what it was at the row `first`."""
    level, way, begin, many = force[first], np.sign(force[first] - force[last]), last + 1, 64
    while begin < len(force):
        there = np.flatnonzero(way * (force[begin : begin + many] - level) >= 0)
        if len(there):
            row = begin + int(there[0])
            share = (level - force[row - 1]) / (force[row] - force[row - 1])
            return float(time[row - 1] + share * (time[row] - time[row - 1]))
        begin, many = begin + many, 2 * many
    return float(time[-1])


def record_content(scene: Scene) -> dict[str, Any] | None:
    """For JSON: how files were read, what reduction and noise make of W; None where nothing was
    measured.
    """
    read, found = read_in_pairs(scene), check_record(scene)
    if not read and found is None:
        return None
    said = list(record_in_words(scene, found)) if found else []
    numbers = asdict(found) | {"by_noise": found.by_noise} if found else None
    return {"read_as": read, "loads": numbers, "sentences": [words for words, _ in said]}


def read_in_pairs(scene: Scene) -> dict[str, ReadAs]:
    """How each file beside the scene was read, by its key: what was found in it, what was stated,
    what was assumed.
    """
    profile = getattr(scene.profile, "fitted", None) or scene.profile
    tables = (("load.file", scene.load), ("profile.file", profile))
    found = {name: getattr(table, "read_as", None) for name, table in tables}
    return {name: pairs for name, pairs in found.items() if pairs}


def section(scene: Scene, solutions: Sequence[ContactSolution]) -> dict[str, Any] | None:
    """What the page shows of measured data: how files were read, sentences on the record, its
    cycles; None where there is none.
    """
    read, record = read_in_pairs(scene), check_record(scene)
    if not read and record is None:
        return None
    cycles = [
        (name_of(one.engine).capitalize(), found)
        for one in solutions
        if (found := load_cycles(one)) is not None
    ]
    first = cycles[0][1].cycles if cycles else ()
    most = sorted(range(len(first)), key=lambda k: -first[k].dissipation)[:_SHOWN]
    return {
        "read": read,
        "said": list(record_in_words(scene, record)) if record else [],
        "cycles": cycles,
        "most": most,
    }
