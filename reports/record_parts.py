"""Parts of a measured record: without load, loading, rest, run-in, cycles that are alike, drift,
gross sliding; each with its rows.

# notation: P, Q loads; f friction coefficient

Cycles of Q lie between turning points whose swings are no smaller than a share of the largest. They
are alike where the ranges of Q are those of the last half of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.units import load_unit, number
from scenes import Scene, TimeSeriesLoad
from scenes.array_types import Array
from scenes.measured import turning_points

_TIME, _NORMAL, _TANGENTIAL = range(3)
# Of the largest P: what is below is no load that is measured well.
_NO_LOAD = 0.05
# Of the range of Q: smaller swings are no cycles.
_SWING = 0.2
# Of the range of P and of Q: what moves less over a cycle's rows is at rest.
_AT_REST = 0.05
# Ranges of Q that differ by more than this share from those of the last half are of other cycles;
# noise of a per cent makes less.
_UNLIKE = 0.1
# Of the range of Q: a mean of Q that moves by more over the cycles drifts.
_DRIFT = 0.05
# Fewer cycles do not show which of them are alike.
_FEWEST_CYCLES = 3
_MOST_ROWS = 200_000
_NEARLY_ALL = 0.9  # of the rows

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class RecordPart:
    """Rows of a record, numbered from 1 on; what they are, in words."""

    kind: str  # "no load", "loading", "rest", "other cycles", "alike", "drift"
    first: int
    last: int
    words: str

    @property
    def sentence(self) -> str:
        """Rows and words."""
        return f"Rows {self.first:,} to {self.last:,}: {self.words}."


@dataclass(frozen=True, eq=False)
class _Cycles:
    """The swings of Q of a record, each between two turning points.

    `turns` (n + 1,) are the rows of the turning points, `ranges` and `means` (n,) those of Q in
    each swing.
    """

    turns: NDArray[np.int64]
    ranges: Array
    means: Array

    @property
    def rows_of_cycle(self) -> int:
        """Rows of two swings, at the median."""
        return max(int(2 * np.median(np.diff(self.turns))), 2)


def record_parts(scene: Scene) -> tuple[RecordPart, ...]:
    """The parts of a record in the order of their first rows; empty for other loads, for rows that
    are one cycle, and for records too long to look through.

    Examples
    --------
    >>> from scenes import TimeSeriesLoad, load_scene
    >>> t = np.arange(800) / 100
    >>> normal = np.where(t < 1, 0.1, 90.0)
    >>> tangential = np.where((t > 2) & (t < 7), 20 * np.sin(2 * np.pi * t), 0.0)
    >>> rows = np.column_stack([t, normal, tangential])
    >>> scene = load_scene("hertz-paper").vary(load=TimeSeriesLoad(rows=rows))
    >>> [(part.kind, part.first, part.last) for part in record_parts(scene)]
    [('no load', 1, 100), ('rest', 101, 202), ('alike', 226, 676), ('rest', 700, 800)]
    """
    load = scene.load
    if not isinstance(load, TimeSeriesLoad) or load.repeats or load.is_driven:
        return ()
    first_row, row_beyond = load.bounds()
    rows = load.rows.values[first_row:row_beyond]
    if len(rows) > _MOST_ROWS:
        return ()
    unit = load_unit(scene)
    has_no_load = rows[:, _NORMAL] < _NO_LOAD * float(np.max(rows[:, _NORMAL]))
    cycles = _cycles_of(rows, ~has_no_load)
    parts: list[RecordPart] = []
    words_of_no_load = f"no load: P is below {100 * _NO_LOAD:g} % of its largest"
    for begin, end in _stretches(has_no_load):
        if end - begin > 2:
            parts.append(RecordPart("no load", begin + 1, end, words_of_no_load))
    if cycles is not None:
        is_at_rest = _at_rest(rows, cycles.rows_of_cycle) & ~has_no_load
        for begin, end in _stretches(is_at_rest):
            parts.append(RecordPart("rest", begin + 1, end, "at rest: neither P nor Q moves"))
        parts += _parts_of_cycles(cycles, unit)
    ordered_parts = sorted(parts, key=lambda part: (part.first, part.last))
    return tuple(
        RecordPart(part.kind, part.first + first_row, part.last + first_row, part.words)
        for part in ordered_parts
    )


def _cycles_of(rows: Array, is_loaded: Mask) -> _Cycles | None:
    """Cycles of Q while there is a load; None for too few."""
    tangential = np.where(is_loaded, rows[:, _TANGENTIAL], 0.0)
    turns = turns_of(tangential)
    if len(turns) < 2 * _FEWEST_CYCLES:
        return None
    return _Cycles(
        turns=turns,
        ranges=np.abs(np.diff(tangential[turns])),
        means=(tangential[turns[1:]] + tangential[turns[:-1]]) / 2,
    )


def turns_of(force: Array) -> NDArray[np.int64]:
    """Rows (m,) at which a force (n,) turns, swings that are no cycles left out.

    >>> turns_of(np.array([0.0, 1.0, -1.0, -0.9, -1.0, 1.0, 0.0])).tolist()
    [1, 2, 5]
    """
    swing = _SWING * float(np.ptp(force))
    # the first is where the first swing begins, which may be anywhere
    return turning_points(force, swing)[1:]


def _at_rest(rows: Array, count: int) -> Mask:
    """Which rows of a record (n, 3: time, P, Q) are at rest: those that lie in a run of at least
    `count` rows over which neither P nor Q moves, (n,).
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    if len(rows) < count:
        return np.zeros(len(rows), dtype=bool)
    window_is_at_rest = np.ones(len(rows) - count + 1, dtype=bool)
    for column in (_NORMAL, _TANGENTIAL):
        first_centre = count // 2
        # extremes of P or Q over every window of `count` rows, by its first row
        highest_load = maximum_filter1d(rows[:, column], count)[first_centre:][
            : len(window_is_at_rest)
        ]
        lowest_load = minimum_filter1d(rows[:, column], count)[first_centre:][
            : len(window_is_at_rest)
        ]
        window_is_at_rest &= highest_load - lowest_load <= _AT_REST * float(np.ptp(rows[:, column]))
    # a row is at rest if any window that holds it is
    windows_until_row = np.cumsum(
        np.concatenate([window_is_at_rest, np.zeros(count - 1, dtype=bool)]).astype(int)
    )
    windows_before = np.concatenate([np.zeros(count, dtype=int), windows_until_row[:-count]])
    return np.asarray(windows_until_row > windows_before)


def _stretches(mask: Mask) -> Iterator[tuple[int, int]]:
    """First row, and row behind the last, of each stretch of rows that are true.

    >>> list(_stretches(np.array([True, True, False, True])))
    [(0, 2), (3, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _parts_of_cycles(cycles: _Cycles, unit: str) -> list[RecordPart]:
    """Divide a record of loads into parts by the range of Q of its cycles: runs of cycles whose
    ranges are alike, runs of other cycles (run-in), and drifts, over which the mean of Q of alike
    cycles moves.

    `unit` is that of the loads.
    """
    median_range = float(np.median(cycles.ranges[len(cycles.ranges) // 2 :]))
    is_alike = np.abs(cycles.ranges - median_range) <= _UNLIKE * median_range
    parts = []
    for first_cycle, cycle_beyond in _stretches(is_alike):
        # a single cycle is no run
        if cycle_beyond - first_cycle < 2:
            is_alike[first_cycle:cycle_beyond] = False
    for first_cycle, cycle_beyond in _stretches(~is_alike):
        first_row = int(cycles.turns[first_cycle]) + 1
        last_row = int(cycles.turns[cycle_beyond]) + 1
        ranges_of_part = cycles.ranges[first_cycle:cycle_beyond]
        preposition = "from" if cycle_beyond - first_cycle > 1 else "of"
        sizes_in_words = f"{preposition} {number(float(ranges_of_part[0]))}"
        if cycle_beyond - first_cycle > 1:
            sizes_in_words += f" to {number(float(ranges_of_part[-1]))}"
        name_of_part = "run-in" if first_cycle == 0 else "other cycles"
        words_of_part = (
            f"{name_of_part}, {_count(cycle_beyond - first_cycle)} with ranges of Q"
            f" {sizes_in_words} {unit}"
        )
        parts.append(RecordPart("other cycles", first_row, last_row, words_of_part))
    for first_cycle, cycle_beyond in _stretches(is_alike):
        first_row = int(cycles.turns[first_cycle]) + 1
        last_row = int(cycles.turns[cycle_beyond]) + 1
        words_of_part = (
            f"{_count(cycle_beyond - first_cycle)} that are alike, range of Q"
            f" {number(float(np.mean(cycles.ranges[first_cycle:cycle_beyond])))} {unit}"
        )
        parts.append(RecordPart("alike", first_row, last_row, words_of_part))
        means_of_part = cycles.means[first_cycle:cycle_beyond]
        drift_of_mean = float(means_of_part[-2:].mean() - means_of_part[:2].mean())
        if cycle_beyond - first_cycle > 4 and abs(drift_of_mean) > _DRIFT * median_range:
            words_of_part = f"drift: the mean of Q moves by {number(drift_of_mean)} {unit}"
            parts.append(RecordPart("drift", first_row, last_row, words_of_part))
    return parts


def _count(n_swings: int) -> str:
    """Swings as cycles.

    >>> _count(2), _count(5)
    ('1 cycle', '2.5 cycles')
    """
    return f"{n_swings / 2:g} {'cycle' if n_swings == 2 else 'cycles'}"


def parts_in_words(scene: Scene) -> list[str]:
    """Sentences on the parts of a record of loads (no load, rest, run-in, alike cycles), and on the
    keys of the scene by which only the cycles that are alike are kept. Empty where one part is
    nearly the whole record.
    """
    parts = record_parts(scene)
    cycles_alike = [part for part in parts if part.kind == "alike"]
    if not parts or (len(parts) == 1 and _is_nearly_all(scene, parts[0])):
        return []
    sentences = [part.sentence for part in parts]
    if cycles_alike:
        longest = max(cycles_alike, key=lambda part: part.last - part.first)
        sentences.append(
            "W is that of all rows. For the cycles that are alike write load.start = {row ="
            f" {longest.first}}} and load.end = {{row = {longest.last}}}."
        )
    return sentences


def _is_nearly_all(scene: Scene, part: RecordPart) -> bool:
    """Whether a part has nearly all of the rows that count."""
    assert isinstance(scene.load, TimeSeriesLoad)
    first_row, row_beyond = scene.load.bounds()
    return part.last - part.first + 1 > _NEARLY_ALL * (row_beyond - first_row)


def sliding_in_words(load: TimeSeriesLoad, friction: float) -> str:
    """Which rows of a record slide as a whole, and the cures; empty where none does. Rows with
    hardly any load count for noise.
    """
    first_row, row_beyond = load.bounds()
    rows = load.rows.values[first_row:row_beyond]
    normal_load = rows[:, _NORMAL]
    slides = np.abs(rows[:, _TANGENTIAL]) > friction * normal_load
    slides &= normal_load >= _NO_LOAD * float(np.max(normal_load))
    if not np.any(slides):
        return ""
    first_sliding_row, last_sliding_row = (np.flatnonzero(slides)[[0, -1]] + first_row + 1).tolist()
    n_strokes = sum(1 for _ in _stretches(slides))
    highest_ratio = float(np.max(np.abs(rows[slides, _TANGENTIAL]) / normal_load[slides]))
    ways_to_leave_out = []
    if first_sliding_row - first_row > 2:
        ways_to_leave_out.append(f"load.end = {{row = {first_sliding_row - 1}}}")
    if row_beyond - last_sliding_row > 1:
        ways_to_leave_out.append(f"load.start = {{row = {last_sliding_row + 1}}}")
    leave_out_in_words = (
        f"; or leave them out by {' or '.join(ways_to_leave_out)}" if ways_to_leave_out else ""
    )
    return (
        f"{np.count_nonzero(slides):,} rows between {first_sliding_row:,} and {last_sliding_row:,}"
        f" slide as a whole, in {n_strokes} {'stroke' if n_strokes == 1 else 'strokes'}, with |Q|/P"
        f" up to {highest_ratio:.4g}. Given loads have no such state: prescribe the displacement"
        " that the rig measured, by tangential_displacement = true and a column U; or check"
        f" friction.coefficient{leave_out_in_words}"
    )
