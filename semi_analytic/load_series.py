"""Load series: paths of straight steps, two or a million of them, and the memory curve as a list of
knots (Masing rule).

# notation: (P, Q) loads; M(eta) memory curve, its knots joined by straight lines; s direction of
#           slip; P_c load at the front of slip; level s Q - f P, which grows in slip

A step loads in full stick and adds a knot; or it slips, and its front goes down through the lines
between the knots; or it unloads, on one side of the curve or along it. Every knot is put on once
and taken off once. A line keeps its own length and rise, so that P - P_c is a sum of lengths and
keeps its digits, however little slips.

A step leaves one record for each line that it goes through: along it P, P_c, Q and the level are
linear in one another. Rows are taken a block at a time: what stays in memory is what was asked for,
and the knots that are alive.
"""

from __future__ import annotations

import gc
from array import array
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from scenes import (
    InadmissibleLoadError,
    InputError,
    LoadPath,
    LoadSegment,
    Scene,
    StraightSegment,
    TimeSeriesLoad,
)
from semi_analytic.history import SLACK, check, evenly, turns_of, within
from semi_analytic.memory import Curve, Instant, Snapshot, repeats_within

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Share of the rates of P and Q below which growth of a level is rounding.
_NOISE = 1e-14
# Share of f P by which a front may miss the knot that it meets.
_LAST_DIGITS = 4e-15
# Share of f P within which a path runs along the curve that it unloads, and share within which a
# line goes straight on.
_ALONG, _STRAIGHT_ON = 8e-15, 1e-15
# Steps that are followed at a time.
_BLOCK = 10_000
# Rows beyond which a path is answered at its rows, with pointwise fields at about so many of them.
_MANY, _FEW = 1000, 400
# Share of a step within which somebody else's instant is a row.
_SLACK_OF_STEP = 1e-6
_NO_LEG = StraightSegment(0.0, 1.0, (0.0, 0.0), (0.0, 0.0))


# --------------------------------------------------------------------------- the curve and one step
class Knot(NamedTuple):
    """The uppermost line of a memory curve, and by `below` the whole curve; None for bodies out of
    contact.

    `top` and `force` are eta and M at its upper end, `length` and `rise` their growth along it,
    `depth` is the number of lines. Fields read it as a `memory.Piece` that is straight.
    """

    below: Knot | None
    top: float
    force: float
    length: float
    rise: float
    depth: int

    @property
    def bottom(self) -> float:
        """eta at the lower end."""
        return self.below.top if self.below is not None else 0.0

    @property
    def slope(self) -> float:
        """dM/d eta."""
        return self.rise / self.length

    @property
    def anchor(self) -> Instant:
        """The upper end; plays no part."""
        return Instant(_NO_LEG, 0.0, self.top, self.force)

    @property
    def bend(self) -> float:
        """None."""
        return 0.0

    @property
    def arc(self) -> None:
        """None."""
        return


_knot = tuple.__new__  # half the time of the class, a million times
_OPEN = Knot(None, 0.0, 0.0, 1.0, 0.0, 0)  # in place of a line where nothing touches
Station = tuple[float, float, float]
"""P, Q and the share of the step that is over."""
Rows = tuple[Callable[["Knot | None"], None], Callable[[Iterable[float]], None]]
"""Where records go while steps are followed: the line of the memory that each goes through; the
columns of `Records` but for the row, then top, force, length and rise of that line."""
_UNLOADS = 2


def sides_of(rows: Array, friction: float) -> NDArray[np.int8]:
    """How the memory takes the steps between rows (n + 1, 2), (n,): slip to a side, 1 or -1, full
    stick, 0, or `_UNLOADS`.
    """
    growth, rise = np.diff(rows, axis=0).T
    limit = friction * growth
    noise = _NOISE * (np.abs(rise) + np.abs(limit))
    forward, reverse = rise - limit > noise, -rise - limit > noise
    return np.where(
        (growth < 0) & (forward == reverse),
        _UNLOADS,
        np.where(forward, 1, np.where(reverse, -1, 0)),
    ).astype(np.int8)


def _shortened(curve: Knot, part: float) -> Knot:
    """The curve without the upper `part` < 1 of its uppermost line; the lowest line begins at 0, to
    the last digit.
    """
    below, top, force, length, rise, depth = curve
    left_length = (1 - part) * length
    left_rise = (1 - part) * rise
    if below is None:
        return _knot(Knot, (None, left_length, left_rise, left_length, left_rise, depth))
    return _knot(
        Knot, (below, top - part * length, force - part * rise, left_length, left_rise, depth)
    )


def _step(
    curve: Knot | None,
    side: int,
    load: float,
    force: float,
    normal: float,
    tangential: float,
    friction: float,
    records: Rows,
) -> Knot | None:
    """The curve after a straight step from P, Q = (load, force) to (normal, tangential), which it
    takes as `sides_of` says.
    """
    if side == _UNLOADS:
        return _unload(curve, (load, force, 0.0), (normal, tangential, 1.0), friction, records)
    if side:
        return _slip(curve, side, load, force, 0.0, normal, tangential, 1.0, friction, records)
    growth, rise = normal - load, tangential - force
    if growth > 0:
        below, length = curve, growth
        if curve is not None:
            one, other = curve.rise * length, rise * curve.length
            if abs(one - other) <= _STRAIGHT_ON * (abs(one) + abs(other)):
                below, length, rise = curve.below, length + curve.length, rise + curve.rise
        if below is None:
            length = normal
        curve = _knot(
            Knot,
            (below, normal, tangential, length, rise, below.depth + 1 if below is not None else 1),
        )
    records[0](curve)
    records[1]((0, load, normal, 0.0, 0.0, 0.0, 1.0, *(curve or _OPEN)[1:5]))
    return curve


def _slip(
    curve: Knot | None,
    s: int,
    load: float,
    force: float,
    begin: float,
    normal: float,
    tangential: float,
    end: float,
    friction: float,
    records: Rows,
) -> Knot | None:
    """Slip in direction s from (load, force) at the share `begin` of the step: the front goes down
    through the lines.
    """
    start, growth, until, (line, numbers) = load, normal - load, begin, records
    total = rest = s * (tangential - force) - friction * growth
    digits = _LAST_DIGITS * friction * (load if load > normal else normal)
    slid = passed = part = length = 0.0
    # What slips already is at the limit, and the front is below it.
    if curve is not None and curve[0] is not None and friction * curve[3] <= s * curve[4]:
        slid = passed = curve[3]
        curve = curve[0]
    while curve is not None:
        below, top, held, length, rise, _ = curve
        needed = friction * length - s * rise
        # A front that meets a knot at the very end of the step, to rounding, has not passed it:
        # what lies below may be at the limit already, and the front would jump through it.
        if rest <= needed + digits or below is None:
            # |Q| <= f P was checked: what the lowest line has not room for is rounding.
            if needed > 0 and rest > 0:
                part = rest / needed if rest < needed else 1.0
            break
        passed += length
        if needed > 0:
            rest -= needed
            share = 1 - rest / total
            after, slipped, until = (
                start + share * growth,
                passed + share * growth,
                begin + share * (end - begin),
            )
            line(curve)
            numbers((s, load, after, slid, slipped, needed, until, top, held, length, rise))
            load, slid = after, slipped
        else:
            slid += length
        curve = below
    slipped = passed + part * length + growth
    line(curve)
    last = (s, load, normal, slid, slipped if slipped > 0 else 0.0, rest if rest > 0 else 0.0, end)
    numbers((*last, *(curve or _OPEN)[1:5]))
    if part > 0:
        curve = _shortened(curve, part) if curve is not None and part < 1 else below
    if not slipped > 0:
        return curve
    if curve is None:
        slipped = normal
    return _knot(
        Knot,
        (
            curve,
            normal,
            tangential,
            slipped,
            s * friction * slipped,
            curve[5] + 1 if curve is not None else 1,
        ),
    )


def _unload(
    curve: Knot | None, first: Station, last: Station, friction: float, records: Rows
) -> Knot | None:
    """P falls and |dQ| <= f |dP|: slip to the side of the curve on which the path runs, in parts
    where it crosses the curve.

    The admissible cones of later points lie inside those of earlier ones, so the state is that of
    one step.
    """
    drop, slope, noise = (
        first[0] - last[0],
        (last[1] - first[1]) / (last[0] - first[0]),
        _ALONG * friction * first[0],
    )
    runs: list[tuple[float, int]] = []  # (fall of P at the end, side) of each part but the last
    down, above, before, line = 0.0, 0.0, 0, curve
    here = 0  # side of the part that goes on
    while line is not None and down < drop:
        below, _, _, length, rise, _ = line
        step = length if length < drop - down else drop - down
        now = above + rise * (step / length) - slope * step
        side = 0 if abs(now) <= noise else (1 if now > 0 else -1)
        if side * before < 0:
            runs.append((down + step * above / (above - now), before))
        elif down > 0 and (side or before) != here:
            runs.append((down, here))
        here = side or before
        down += step
        above, before, line = now, side, below
    begin = first
    for fall, side in runs:
        end = (
            first[0] - fall,
            first[1] - slope * fall,
            first[2] + fall / drop * (last[2] - first[2]),
        )
        curve = (
            _slip(curve, side, *begin, *end, friction, records)
            if side
            else _along(curve, begin, end, records)
        )
        begin = end
    curve = (
        _slip(curve, here, *begin, *last, friction, records)
        if here
        else _along(curve, begin, last, records)
    )
    return curve if last[0] > 0 else None


def _along(curve: Knot | None, first: Station, last: Station, records: Rows) -> Knot | None:
    """Unload along the curve itself: nothing slips."""
    drop = rest = first[0] - last[0]
    begin = first
    while curve is not None and rest > 0 and begin is not last:
        below, top, force, length, rise, _ = curve
        part, rest = rest / length, rest - length
        after = 1 - max(rest, 0.0) / drop
        end = (
            last
            if below is None or rest <= 0
            else (first[0] - after * drop, 0.0, first[2] + after * (last[2] - first[2]))
        )
        records[0](curve)
        records[1]((0, begin[0], end[0], 0.0, 0.0, 0.0, end[2], top, force, length, rise))
        begin = end
        curve = _shortened(curve, part) if part < 1 else below
    if begin is not last:
        records[0](curve)
        records[1]((0, begin[0], last[0], 0.0, 0.0, 0.0, last[2], *(curve or _OPEN)[1:5]))
    return curve


class Records(NamedTuple):
    """Parts of steps, (m,) each: direction of slip (0: none), P and P - P_c at both ends, rise of
    the level, share of the step that is over at the end, and `row`, the number of the step.
    """

    direction: Array
    load: Array
    load_after: Array
    slipped: Array
    slipped_after: Array
    rise: Array
    until: Array
    row: Indices

    def take(self, some: NDArray[np.bool_] | Indices | slice) -> Records:
        """Some of them."""
        return Records._make(column[some] for column in self)

    def with_front_in_contact(self) -> Records:
        """The same with P_c >= 0: of a contact that slips throughout, as next to full unloading,
        the sum of lengths of lines may be a last digit more than P.
        """
        slipped = np.minimum(self.slipped, self.load)
        slipped_after = np.minimum(self.slipped_after, self.load_after)
        return self._replace(slipped=slipped, slipped_after=slipped_after)

    def slipping(self) -> Records:
        """Those that slip."""
        return self.take(self.direction != 0)


class Block(NamedTuple):
    """What steps from row to row (n + 1, 2) leave: records, the line of each, its top, force,
    length and rise, (4, m), the curve at the end, most lines alive.
    """

    rows: Array
    records: Records
    lines: list[Knot | None]
    ends: Array
    curve: Knot | None
    alive: int

    @property
    def deepest(self) -> float:
        """The largest P - P_c."""
        return float(
            np.max(np.maximum(self.records.slipped, self.records.slipped_after), initial=0.0)
        )


def depth_of(curve: Knot | None) -> int:
    """Number of lines."""
    return curve.depth if curve is not None else 0


def follow(curve: Knot | None, rows: Array, friction: float, curves: bool = False) -> Block:
    """Straight steps from the first of `rows` (n + 1, 2) of P and Q, where the memory is `curve`,
    to each of the others.

    >>> block = follow(None, np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [2.0, -0.5]]), 0.5)
    >>> block.records.slipped_after.tolist(), block.alive  # Q/f, then (Q - Q')/(2 f)
    ([0.0, 1.0, 1.0], 2)
    """
    lines: list[Knot | None] = []
    numbers, counts, alive = array("d"), [0], 0
    records = lines.append if curves else deque[Any](maxlen=0).append, numbers.extend
    # A path that unloads fully may end below 0 by rounding.
    rows = np.stack([np.maximum(rows[:, 0], 0.0), rows[:, 1]], axis=1)
    p, q = rows[0].tolist()
    # Nothing here can hold itself: the garbage collector would look at all other objects again and
    # again, for half of the time.
    collects = gc.isenabled()
    gc.disable()
    try:
        for (normal, tangential), side in zip(
            rows[1:].tolist(), sides_of(rows, friction).tolist(), strict=True
        ):
            curve = _step(curve, side, p, q, normal, tangential, friction, records)
            if normal == 0:
                curve = None  # unloaded: a line that rounding left has no length
            p, q = normal, tangential
            counts.append(len(numbers))
            if curve is not None and curve.depth > alive:
                alive = curve.depth
    finally:
        if collects:
            gc.enable()
    table = np.frombuffer(numbers).reshape(-1, 11).T
    steps = np.repeat(np.arange(len(rows) - 1), np.diff(counts) // 11)
    parts_of_steps = Records._make([*table[:7], steps]).with_front_in_contact()
    return Block(rows, parts_of_steps, lines, table[7:], curve, alive)


def knots_of(curve: Knot | None) -> Array:
    """(eta, M) of the knots, ascending from (0, 0): (2, n)."""
    points = [(0.0, 0.0)]
    while curve is not None:
        points.insert(1, (curve.top, curve.force))
        curve = curve.below
    return np.array(points).T


def _alike(one: Knot | None, other: Knot | None, friction: float, tolerance: float) -> bool:
    """Whether two curves agree within `tolerance` f P at the knots of both."""
    first, second = knots_of(one), knots_of(other)
    knots = np.union1d(first[0], second[0])
    apart = np.abs(np.interp(knots, *first) - np.interp(knots, *second))
    return bool(
        abs(first[0, -1] - second[0, -1]) <= tolerance * knots[-1]
        and np.all(apart <= tolerance * friction * knots[-1])
    )


# ----------------------------------------------------------------------------------- the whole path
class Part(NamedTuple):
    """A part of a path: rows (m + 1, 3) of time, P and Q, what makes their time the path's, the
    memory at the first row.
    """

    rows: Array
    delay: float
    curve: Knot | None = None


@dataclass(frozen=True, eq=False)
class LoadSeries:
    """A path of straight steps that has been followed.

    Attributes
    ----------
    friction : f
    parts : initial loading, where the path has a period, and each solved cycle; the whole path
    where it has none first : number of the first cycle among the parts
    steady_from : index of the first cycle that ends in the state it started from, None if none did
    period : duration of a cycle, None for a path that does not repeat
    covered : for each whole cycle that the answer covers, the index of the solved cycle that it is
    or is a copy of repeats : whether cycles after the steady one are copies
    long : whether it is a measured series of more than 1,000 rows, which is answered at its rows
    """

    friction: float
    parts: tuple[Part, ...]
    first: int
    steady_from: int | None
    period: float | None = None
    covered: tuple[int, ...] = (0,)
    repeats: bool = False
    long: bool = False

    @property
    def cycles(self) -> tuple[Part, ...]:
        """The solved cycles."""
        return self.parts[self.first :]

    @property
    def largest(self) -> float:
        """The largest P."""
        return max(float(np.max(part.rows[:, 1])) for part in self.parts)

    @cached_property
    def times(self) -> Array:
        """Of all rows, ascending."""
        return np.concatenate(
            [self.parts[0].rows[:1, 0], *(part.rows[1:, 0] + part.delay for part in self.parts)]
        )

    @cached_property
    def starts(self) -> Indices:
        """Number of the first step of each part, and of steps in all."""
        return np.cumsum([0, *(len(part.rows) - 1 for part in self.parts)])

    def default_times(self, steady: bool, few: bool) -> tuple[Array, int]:
        """Instants where none are asked for, and how many rows of a long path are left out where a
        `few` will do.

        About 400 a cycle, evenly spread over each record, both its ends among them; of a long path
        the rows.
        """
        begin = len(self.parts) - 1 if steady else 0
        if self.long:
            rows = self.times[self.starts[begin] :]
            chosen = np.unique(
                np.append(rows[:: max(len(rows) // _FEW, 1) if few else 1], rows[-1])
            )
            return chosen, len(rows) - len(chosen)
        times = []
        for number, part in enumerate(self.parts[begin:], begin):
            block = follow(part.curve, part.rows[:, 1:], self.friction)
            at = self.times[self.starts[number] :]
            before, after, until = (
                at[block.records.row],
                at[block.records.row + 1],
                block.records.until,
            )
            marks = np.unique(
                np.append(at[0], np.where(until == 1, after, before + until * (after - before)))
            )
            times.append(evenly(marks, initial=number < self.first))
        return np.unique(np.concatenate(times)), 0

    def locate(self, time: Array) -> tuple[Indices, Array, Array]:
        """Number of the step, share of it that is over, and share within which two instants are
        one: (n,) each.

        An instant between two steps belongs to the one that ends there.

        Raises
        ------
        InputError
            For a time outside the path.
        """
        times = self.times
        inside, slack = within(time, float(times[0]), float(times[-1]), self.period)
        row = np.clip(np.searchsorted(times, inside, side="left"), 1, len(times) - 1)
        near = np.minimum(slack / np.diff(times), _SLACK_OF_STEP)
        # A row that somebody else found to rounding is still the row.
        back = (row > 1) & (
            inside - times[row - 1] <= near[row - 1] * (times[row] - times[row - 1])
        )
        step = row - 1 - back
        share = (inside - times[step]) / (times[step + 1] - times[step])
        return step, np.where(share > 1 - near[step], 1.0, np.maximum(share, 0.0)), near[step]


def own_series(scene: Scene, time: Array | None) -> LoadSeries:
    """The scene's own path of straight legs: as many cycles as `time` needs; until it is steady
    where it needs none.

    Raises
    ------
    InadmissibleLoadError
        For gross sliding or separation, with the instant and the loads.
    """
    friction, load, long = scene.friction.coefficient, scene.load, False
    if isinstance(load, TimeSeriesLoad):  # a leg for each of a million rows would take a gigabyte
        rows, long = load.series(), len(load.kept_rows()) > _MANY
        loading, cycle = (rows[:2], rows[1:]) if load.repeats else (rows, rows[:0])
    else:
        path = load.path()
        loading, cycle = _rows_of(path.initial_loading), _rows_of(path.cycle)
    check_rows(loading, friction)
    if not len(cycle):
        return replace(_single(friction, loading), long=long)
    check_rows(cycle, friction)
    period = float(cycle[-1, 0] - cycle[0, 0])
    most, whole = turns_of(float(cycle[0, 0]), period, scene.cycles, time)
    turns = (Part(cycle, k * period) for k in range(most))
    return replace(_followed(friction, Part(loading, 0.0), turns, period, whole), long=long)


def _rows_of(legs: Sequence[LoadSegment]) -> Array:
    """Time, P and Q at the ends of legs: (m + 1, 3), or (0, 3)."""
    stations = [*((leg.start, leg) for leg in legs[:1]), *((leg.end, leg) for leg in legs)]
    return np.array(
        [[time, *(float(load) for load in leg.loads(time))] for time, leg in stations]
    ).reshape(-1, 3)


def straight_series(path: LoadPath, friction: float, time: Array) -> LoadSeries:
    """Straight lines between the path's points at `time`, ascending; from (0, 0) to the first of
    them too.

    A revolution that starts between two of the times starts on the straight line between them.
    """
    if path.has_bulk_or_tilt:
        raise InputError("straight_steps: not with bulk stress or tilt")
    if np.any(np.diff(time) <= 0):
        raise InputError("straight_steps: the times must ascend, no two of them equal")
    times = np.concatenate([[path.start], time]) if float(time[0]) > path.start else time
    if len(times) < 2:
        raise InputError(
            f"straight_steps: no time is after the start of the load path, {path.start:.6g}"
        )
    rows = np.stack([times, *path.at(times)], axis=1)
    check_rows(rows, friction)
    slack = SLACK * (path.period or 0.0)
    if path.period is None or times[-1] <= path.cycle_start + slack:
        return _single(friction, rows)
    _, whole = turns_of(path.cycle_start, path.period, 1, time)
    marks = path.cycle_start + path.period * np.arange(whole + 1)
    near = np.abs(times[:, None] - marks) <= slack
    every = np.sort(np.concatenate([times, marks[~near.any(axis=0) & (marks < times[-1])]]))
    rows = np.stack([every, *(np.interp(every, times, rows[:, k]) for k in (1, 2))], axis=1)
    turn = np.searchsorted(marks - slack, every[:-1], side="right")
    bounds = [0, *np.flatnonzero(np.diff(turn, prepend=0)).tolist(), len(every) - 1]
    loading, *turns = (Part(rows[a : b + 1], 0.0) for a, b in pairwise(bounds))
    return _followed(friction, loading, turns, path.period, whole, repeats=False)


def check_rows(rows: Array, friction: float) -> None:
    """Raise InadmissibleLoadError at the first gross sliding or separation; lines between
    admissible points are admissible.
    """
    normal, tangential = rows[:, 1], rows[:, 2]
    slack = _NOISE * float(np.max(np.abs(normal)))
    bad = np.flatnonzero((normal < -slack) | (np.abs(tangential) > friction * (normal + slack)))
    if len(bad):
        before, after = rows[max(int(bad[0]) - 1, 0)].tolist(), rows[bad[0]].tolist()
        check(
            [StraightSegment(before[0], after[0], (before[1], before[2]), (after[1], after[2]))],
            friction,
        )
        raise InadmissibleLoadError(
            "separation" if after[1] < -slack else "gross sliding",
            after[0],
            after[1],
            after[2],
            friction,
        )


def _single(friction: float, rows: Array) -> LoadSeries:
    """A path that does not repeat; it ends as it began where it ends unloaded."""
    return LoadSeries(friction, (Part(rows, 0.0),), 0, 0 if rows[-1, 1] <= 0 else None)


def _followed(
    friction: float,
    loading: Part,
    turns: Iterable[Part],
    period: float,
    whole: int,
    *,
    repeats: bool = True,
) -> LoadSeries:
    """The series whose `turns` come one after the other; where they repeat, up to the first that
    ends as it began.
    """
    cycles: list[Part] = []
    steady, curve = None, None
    for _, block in blocks(loading, friction):
        curve = block.curve
    for turn in turns:
        cycles.append(turn._replace(curve=curve))
        deepest = 0.0
        for _, block in blocks(cycles[-1], friction):
            curve, deepest = block.curve, max(deepest, block.deepest)
        if steady is None and _alike(
            cycles[-1].curve,
            curve,
            friction,
            repeats_within(deepest / float(np.max(turn.rows[:, 1]))),
        ):
            steady = len(cycles) - 1
            if repeats:
                break
    covered = tuple(
        min(number, len(cycles) - 1) for number in range(whole or (len(cycles) if repeats else 1))
    )
    return LoadSeries(friction, (loading, *cycles), 1, steady, period, covered, repeats)


def blocks(part: Part, friction: float, curves: bool = False) -> Iterator[tuple[int, Block]]:
    """The steps of a part, a block at a time, and the number of the first."""
    curve = part.curve
    for first in range(0, len(part.rows) - 1, _BLOCK):
        block = follow(curve, part.rows[first : first + _BLOCK + 1, 1:], friction, curves)
        yield first, block
        curve = block.curve


class States:
    """The memory curves of instants, collected block by block."""

    def __init__(self, friction: float, curves: bool) -> None:
        self.friction, self.curves = friction, curves
        self._columns: list[tuple[NDArray[Any], ...]] = []
        self._lines: list[Knot | None] = []

    def add(self, block: Block, step: Indices, share: Array, near: Array) -> None:
        """Instants (n,) at shares of steps of a block; `near` is how far a share may miss the end
        of a record.
        """
        if not len(step):
            return
        records, last = block.records, len(block.records.row) - 1
        number = np.minimum(
            np.searchsorted(records.row + records.until, step + share - near, side="left"), last
        )
        number += records.row[number] < step
        # an instant that counts as the end of a record has the loads of that end
        share = np.minimum(share, records.until[number])
        begin = np.where(
            np.diff(records.row, prepend=-1) > 0, 0.0, np.append(0.0, records.until[:-1])
        )[number]
        part = np.clip(
            (share - begin) / np.maximum(records.until[number] - begin, np.finfo(float).tiny),
            0.0,
            1.0,
        )
        top, held, length, rise = block.ends[:, number]
        bottom, slope = top - length, rise / length
        before, way = block.rows[step], block.rows[step + 1] - block.rows[step]
        load, force = np.where(
            share[:, None] > 0.5,
            before + way - (1 - share)[:, None] * way,
            before + share[:, None] * way,
        ).T
        load = np.maximum(load, 0.0)  # a path that unloads fully may end below 0 by rounding
        s = records.direction[number]
        slipped = records.slipped[number] + part * (records.slipped_after - records.slipped)[number]
        slipped = np.where(
            s != 0,
            np.clip(slipped, np.maximum(load - top, 0.0), np.maximum(load - bottom, 0.0)),
            0.0,
        )
        balance = held - slope * (top - (load - slipped)) + s * self.friction * slipped - force
        used, which = (
            np.unique(number, return_inverse=True)
            if self.curves
            else (number[:0], np.zeros(len(step), dtype=np.intp))
        )
        self._columns.append((load, force, slipped, s, which + len(self._lines), balance))
        self._lines += [block.lines[k] for k in used.tolist()]

    def snapshot(self, time: Array, back: Indices) -> tuple[Snapshot, Array]:
        """All of them in the order of `time`, and M(P) - Q."""
        load, force, slipped, s, which, balance = (
            np.concatenate(column)[back] for column in zip(*self._columns, strict=True)
        )
        lines = cast(tuple[Curve, ...], tuple(self._lines) or (None,))
        return (
            Snapshot(time, load, force, slipped, s.astype(np.int64), which, lines, self.friction),
            balance,
        )
