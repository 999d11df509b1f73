"""Parts of a measured record: without load, loading, rest, run-in, cycles that are alike, drift,
gross sliding; each with its rows.

# notation: P, Q loads; f friction coefficient

A swing goes from one turning point of Q to the next; two swings are a cycle. Swings smaller than a
fifth of the range of Q do not count. Swings are alike where their ranges of Q are within a tenth of
the median of the last half of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.units import load_unit, number
from scenes import Scene, TimeSeriesLoad
from scenes.array_types import Array
from scenes.measured import rows_of_turning_points

_TIME, _NORMAL, _TANGENTIAL = range(3)
# A smaller P, over the largest P, counts as no load: it is not measured well.
_LEAST_SHARE_OF_LOAD = 0.05
# Smaller swings, over the range of Q, do not count.
_LEAST_SHARE_OF_RANGE = 0.2
# A load that moves less over the rows of a cycle, over its range in the record, is at rest.
_LARGEST_MOTION_AT_REST = 0.05
# Ranges of Q that differ by more from the median of the last half, over that median, are of other
# cycles. Noise of a per cent makes less.
_LARGEST_DIFFERENCE_OF_ALIKE = 0.1
# A mean of Q that moves by more over alike cycles, over their range of Q, drifts.
_LEAST_DRIFT_SHARE = 0.05
# Fewer cycles do not show which of them are alike.
_FEWEST_CYCLES = 3
_MOST_ROWS_LOOKED_THROUGH = 200_000
_LEAST_SHARE_OF_NEARLY_ALL = 0.9  # of the rows

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class RecordPart:
    """Neighbouring rows of a record that are of one kind.

    Attributes
    ----------
    kind
        "no load", "rest", "other cycles", "alike" (cycles with one range of Q) or "drift"
    first_row, last_row
        numbers of the rows, from 1 on
    words
        what these rows are
    """

    kind: str
    first_row: int
    last_row: int
    words: str

    @property
    def sentence(self) -> str:
        """Rows and words."""
        return f"Rows {self.first_row:,} to {self.last_row:,}: {self.words}."


@dataclass(frozen=True, eq=False)
class _Swings:
    """The n swings of Q of a record, each from one turning point of Q to the next; two are a cycle.

    Attributes
    ----------
    turns
        (n + 1,) indices of the rows of the turning points
    ranges, means
        (n,) range and mean of Q in each swing [load]
    """

    turns: NDArray[np.int64]
    ranges: Array
    means: Array

    @property
    def n_rows_of_cycle(self) -> int:
        """Number of rows of a cycle: twice the median of those of a swing."""
        return max(int(2 * np.median(np.diff(self.turns))), 2)


def record_parts(scene: Scene) -> tuple[RecordPart, ...]:
    """The parts of a measured record of loads (rows without load, at rest, of cycles that are
    alike, ...) in the order of their first rows. Parts may overlap, and need not hold all rows.

    Empty for other loads, for rows that are one cycle (`repeats`), under a prescribed displacement
    (`is_driven`), and for records of more than 200,000 rows.

    Examples
    --------
    >>> from scenes import TimeSeriesLoad, load_scene
    >>> t = np.arange(800) / 100
    >>> normal = np.where(t < 1, 0.1, 90.0)
    >>> tangential = np.where((t > 2) & (t < 7), 20 * np.sin(2 * np.pi * t), 0.0)
    >>> rows = np.column_stack([t, normal, tangential])
    >>> scene = load_scene("hertz-paper").vary(load=TimeSeriesLoad(rows=rows))
    >>> [(part.kind, part.first_row, part.last_row) for part in record_parts(scene)]
    [('no load', 1, 100), ('rest', 101, 202), ('alike', 226, 676), ('rest', 700, 800)]
    """
    load_record = scene.load
    if not isinstance(load_record, TimeSeriesLoad) or load_record.repeats or load_record.is_driven:
        return ()
    # Numbers, from 0, of the first row used and of the one after the last.
    first_used_row, row_beyond = load_record.row_bounds()
    rows = load_record.rows.values[first_used_row:row_beyond]
    if len(rows) > _MOST_ROWS_LOOKED_THROUGH:
        return ()

    # P below 5 % of its largest; swings of Q between turning points, None for too few.
    # _LEAST_SHARE_OF_LOAD, _NORMAL: 0.05 of the largest P, and the column of P
    has_no_load = rows[:, _NORMAL] < _LEAST_SHARE_OF_LOAD * float(np.max(rows[:, _NORMAL]))
    swings = _swings_of(rows, ~has_no_load)
    parts = list(_parts_without_load(has_no_load))
    if swings is not None:
        parts += _parts_at_rest(_is_at_rest(rows, swings.n_rows_of_cycle) & ~has_no_load)
        parts += _parts_of_swings(swings, load_unit(scene))

    # In the order of the first rows, numbered in the record as a whole.
    # RecordPart: kind, numbers of the first and the last row, words
    ordered_parts = sorted(parts, key=lambda part: (part.first_row, part.last_row))
    return tuple(
        RecordPart(
            part.kind, part.first_row + first_used_row, part.last_row + first_used_row, part.words
        )
        for part in ordered_parts
    )


def _parts_without_load(has_no_load: Mask) -> Iterator[RecordPart]:
    """Parts of a record in which P is below 5 % of its largest: runs of more than two rows for
    which `has_no_load` (n,) is True. Their rows are numbered from 1 on.
    """
    words = f"no load: P is below {100 * _LEAST_SHARE_OF_LOAD:g} % of its largest"
    # Indices begin at 0, numbers of rows at 1: `index_beyond` is the number of the last row.
    for first_index, index_beyond in _bounds_of_runs(has_no_load):
        if index_beyond - first_index > 2:
            yield RecordPart("no load", first_index + 1, index_beyond, words)


def _parts_at_rest(is_at_rest: Mask) -> Iterator[RecordPart]:
    """Parts of a record in which neither P nor Q moves: runs of rows for which `is_at_rest` (n,) is
    True. Their rows are numbered from 1 on.
    """
    words = "at rest: neither P nor Q moves"
    for first_index, index_beyond in _bounds_of_runs(is_at_rest):
        yield RecordPart("rest", first_index + 1, index_beyond, words)


def _swings_of(rows: Array, is_loaded: Mask) -> _Swings | None:
    """Swings of Q, each from one turning point to the next, in rows (n, 3: time, P, Q), with Q = 0
    where there is no load (`is_loaded` (n,) is False); None for fewer than six turning points.
    """
    # _TANGENTIAL: column of Q
    tangential_load = np.where(is_loaded, rows[:, _TANGENTIAL], 0.0)
    # Indices of the rows at which Q turns, small swings left out.
    turning_rows = rows_of_turns(tangential_load)
    # _FEWEST_CYCLES: 3, with two turning points each
    if len(turning_rows) < 2 * _FEWEST_CYCLES:
        return None
    return _Swings(
        turns=turning_rows,
        ranges=np.abs(np.diff(tangential_load[turning_rows])),
        means=(tangential_load[turning_rows[1:]] + tangential_load[turning_rows[:-1]]) / 2,
    )


def rows_of_turns(force: Array) -> NDArray[np.int64]:
    """Indices (m,) of the rows at which a force (n,) turns; swings smaller than a fifth of its
    range are left out.

    >>> rows_of_turns(np.array([0.0, 1.0, -1.0, -0.9, -1.0, 1.0, 0.0])).tolist()
    [1, 2, 5]
    """
    least_swing = _LEAST_SHARE_OF_RANGE * float(np.ptp(force))
    # without the first one, where the first swing begins: the force need not turn there
    return rows_of_turning_points(force, least_swing)[1:]


def _is_at_rest(rows: Array, window_size: int) -> Mask:
    """Whether each row of a record (n, 3: time, P, Q) is at rest, (n,): whether it lies in a window
    of `window_size` neighbouring rows over which neither P nor Q moves by more than 5 % of its
    range.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    n_windows = len(rows) - window_size + 1
    if n_windows < 1:
        return np.zeros(len(rows), dtype=bool)
    # each window is counted by its first row; scipy's filters state a window at its centre
    first_centre = window_size // 2
    centres = slice(first_centre, first_centre + n_windows)
    is_window_at_rest = np.ones(n_windows, dtype=bool)
    # Columns of P and of Q.
    for column in (_NORMAL, _TANGENTIAL):
        load_values = rows[:, column]
        largest_load = maximum_filter1d(load_values, window_size)[centres]
        least_load = minimum_filter1d(load_values, window_size)[centres]
        # _LARGEST_MOTION_AT_REST: 0.05 of the range of the load
        largest_motion = _LARGEST_MOTION_AT_REST * float(np.ptp(load_values))
        is_window_at_rest &= largest_load - least_load <= largest_motion
    # A row is at rest where any window that holds it is. Windows at rest are counted: those that
    # begin at or before the row, minus those that end before it.
    is_start_at_rest = np.concatenate([is_window_at_rest, np.zeros(window_size - 1, dtype=bool)])
    n_windows_begun = np.cumsum(is_start_at_rest.astype(int))
    n_windows_ended = np.concatenate(
        [np.zeros(window_size, dtype=int), n_windows_begun[:-window_size]]
    )
    return np.asarray(n_windows_begun > n_windows_ended)


def _bounds_of_runs(mask: Mask) -> Iterator[tuple[int, int]]:
    """Index of the first row, and of the row after the last, of each run of rows that are True.

    >>> list(_bounds_of_runs(np.array([True, True, False, True])))
    [(0, 2), (3, 4)]
    """
    bounds = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    yield from zip(bounds[::2].tolist(), bounds[1::2].tolist(), strict=True)


def _parts_of_swings(swings: _Swings, unit: str) -> list[RecordPart]:
    """Parts of a record of loads by the range of Q of its swings, each from one turning point to
    the next: runs of alike swings, and runs of swings that are not, of which the first may be the
    run-in.

    Swings are alike whose range of Q is within 10 % of the median of the last half of all. A run of
    five or more alike swings whose mean of Q moves is a drift too.

    Parameters
    ----------
    swings
        `ranges` and `means` (n,) of Q in each swing [load]; `turns` (n + 1,): indices of the rows
        at the turning points
    unit
        of the loads
    """
    median_range = float(np.median(swings.ranges[len(swings.ranges) // 2 :]))
    # _LARGEST_DIFFERENCE_OF_ALIKE: 0.1 of the median range
    is_alike = np.abs(swings.ranges - median_range) <= _LARGEST_DIFFERENCE_OF_ALIKE * median_range

    # A run has two swings at least: a single one counts with those that are not alike.
    for first_swing, swing_beyond in _bounds_of_runs(is_alike):
        is_single_swing = swing_beyond - first_swing < 2
        if is_single_swing:
            is_alike[first_swing] = False

    parts = []
    for first_swing, swing_beyond in _bounds_of_runs(~is_alike):
        first_row = int(swings.turns[first_swing]) + 1
        last_row = int(swings.turns[swing_beyond]) + 1
        words_of_part = _other_cycles_in_words(
            swings.ranges[first_swing:swing_beyond], first_swing, unit
        )
        # RecordPart: kind, numbers of the first and the last row, words
        parts.append(RecordPart("other cycles", first_row, last_row, words_of_part))
    for first_swing, swing_beyond in _bounds_of_runs(is_alike):
        first_row = int(swings.turns[first_swing]) + 1
        last_row = int(swings.turns[swing_beyond]) + 1
        mean_range = number(float(np.mean(swings.ranges[first_swing:swing_beyond])))
        n_swings = swing_beyond - first_swing
        words_of_part = (
            f"{_cycles_in_words(n_swings)} that are alike, range of Q {mean_range} {unit}"
        )
        parts.append(RecordPart("alike", first_row, last_row, words_of_part))
        # Drift: the mean of Q moves by more than 5 % of the median range.
        means_of_part = swings.means[first_swing:swing_beyond]
        drift_of_mean = float(means_of_part[-2:].mean() - means_of_part[:2].mean())
        # _LEAST_DRIFT_SHARE: 0.05 of the median range
        if n_swings > 4 and abs(drift_of_mean) > _LEAST_DRIFT_SHARE * median_range:
            words_of_drift = f"drift: the mean of Q moves by {number(drift_of_mean)} {unit}"
            parts.append(RecordPart("drift", first_row, last_row, words_of_drift))
    return parts


def _other_cycles_in_words(ranges: Array, first_swing: int, unit: str) -> str:
    """Words on a run of swings that are not alike: how many cycles, and the range of Q of the first
    and of the last swing. `ranges` (m,) are those of the swings, `first_swing` is the index of the
    first among all swings of the record: the run is the run-in where it is 0.
    """
    ranges_in_words = f"of {number(float(ranges[0]))}"
    if len(ranges) > 1:
        ranges_in_words = f"from {number(float(ranges[0]))} to {number(float(ranges[-1]))}"
    name = "run-in" if first_swing == 0 else "other cycles"
    return f"{name}, {_cycles_in_words(len(ranges))} with ranges of Q {ranges_in_words} {unit}"


def _cycles_in_words(n_swings: int) -> str:
    """A number of swings as a number of cycles.

    >>> _cycles_in_words(2), _cycles_in_words(5)
    ('1 cycle', '2.5 cycles')
    """
    return f"{n_swings / 2:g} {'cycle' if n_swings == 2 else 'cycles'}"


def parts_in_words(scene: Scene) -> list[str]:
    """Sentences on the parts of a record of loads (no load, rest, run-in, alike cycles), and on the
    keys of the scene that select the longest run of alike cycles. Empty without parts, and where
    one part holds more than nine tenths of the rows.
    """
    # Each with its kind, the numbers of its first and last row, and a sentence.
    parts = record_parts(scene)
    alike_parts = [part for part in parts if part.kind == "alike"]
    if not parts or (len(parts) == 1 and _is_nearly_all(scene, parts[0])):
        return []
    sentences = [part.sentence for part in parts]
    if alike_parts:
        longest_part = max(alike_parts, key=lambda part: part.last_row - part.first_row)
        sentences.append(
            "W is that of all rows. For the cycles that are alike write load.start = {row ="
            f" {longest_part.first_row}}} and load.end = {{row = {longest_part.last_row}}}."
        )
    return sentences


def _is_nearly_all(scene: Scene, part: RecordPart) -> bool:
    """Whether a part holds more than nine tenths of the rows that the scene uses."""
    assert isinstance(scene.load, TimeSeriesLoad)
    first_row, row_beyond = scene.load.row_bounds()
    return part.last_row - part.first_row + 1 > _LEAST_SHARE_OF_NEARLY_ALL * (
        row_beyond - first_row
    )


def sliding_rows_in_words(load_record: TimeSeriesLoad, friction_coefficient: float) -> str:
    """At which rows of a record the bodies slide as a whole (|Q| > f P), and what to do, in words;
    "" where there are none.

    Rows with P below 5 % of its largest are left out: they are noise. The `rows` of `load_record`
    hold time, P and Q.
    """
    # Numbers, from 0, of the first row used and of the one after the last.
    first_row, row_beyond = load_record.row_bounds()
    rows = load_record.rows.values[first_row:row_beyond]
    # _NORMAL: column of P; below, _TANGENTIAL that of Q
    normal_load = rows[:, _NORMAL]
    is_sliding = np.abs(rows[:, _TANGENTIAL]) > friction_coefficient * normal_load
    # _LEAST_SHARE_OF_LOAD: 0.05 of the largest P
    is_sliding &= normal_load >= _LEAST_SHARE_OF_LOAD * float(np.max(normal_load))
    if not np.any(is_sliding):
        return ""
    first_sliding_row, last_sliding_row = (
        np.flatnonzero(is_sliding)[[0, -1]] + first_row + 1
    ).tolist()
    # Runs of neighbouring rows that slide.
    n_strokes = sum(1 for _ in _bounds_of_runs(is_sliding))
    largest_ratio = float(np.max(np.abs(rows[is_sliding, _TANGENTIAL]) / normal_load[is_sliding]))

    # Keys of the scene that leave these rows out, where enough rows remain before or after.
    keys_that_leave_out = []
    if first_sliding_row - first_row > 2:
        keys_that_leave_out.append(f"load.end = {{row = {first_sliding_row - 1}}}")
    if row_beyond - last_sliding_row > 1:
        keys_that_leave_out.append(f"load.start = {{row = {last_sliding_row + 1}}}")
    keys_in_words = ""
    if keys_that_leave_out:
        keys_in_words = f"; or leave them out by {' or '.join(keys_that_leave_out)}"
    return (
        f"{np.count_nonzero(is_sliding):,} rows between {first_sliding_row:,} and"
        f" {last_sliding_row:,} slide as a whole, in {n_strokes}"
        f" {'stroke' if n_strokes == 1 else 'strokes'}, with |Q|/P"
        f" up to {largest_ratio:.4g}. Given loads have no such state: prescribe the displacement"
        " that the rig measured, by tangential_displacement = true and a column U; or check"
        f" friction.coefficient{keys_in_words}"
    )
