"""Paths of straight load steps, two or a million of them: the memory curve as a list of knots, and its friction work.

# notation: (P, Q) loads; M(eta) memory curve, its knots joined by straight lines; s direction of slip; P_c load at the front of
#           slip, c = a(P_c); level s Q - f P, which grows in slip; P_x load at which a = |x|; A = 2/E*

A step loads in full stick and adds a knot; or it slips, and its front goes down through the lines between the knots; or it unloads,
on one side of the curve or along it. Every knot is put on once and taken off once. A line keeps its own length and rise, so that
P - P_c is a sum of lengths and keeps its digits, however little slips.

A step leaves one record for each line that it goes through: along it P, P_c, Q and the level are linear in one another, and

    W = (f A/pi) int Lam(P, P_c) dw,  W(x) = (f A/pi) int p(x, P) arccosh(|x|/c) dw over c < |x| < a(P),  w = s Q - f P.

Rows are taken a block at a time: what stays in memory is what was asked for, and the knots that are alive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import InadmissibleLoadError, InputError, LoadPath, LoadSegment, NotFoundError, Scene, StraightSegment, TimeSeriesLoad
from semi_analytic.contact import Contact, bends_anywhere, corner_loads
from semi_analytic.friction_work import DIGITS_OF_SHIFT, Along
from semi_analytic.history import check, turns_of
from semi_analytic.legs import Instant
from semi_analytic.memory import Curve, Piece, Snapshot
from semi_analytic.quadrature import NODES, ROOTS, gauss, graded
from semi_analytic.request import Request
from semi_analytic.roundoff import repeats_within, rounding_of_slip

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Share of the rates of P and Q below which growth of a level is rounding.
_NOISE = 1e-14
# Share of f P by which a front may miss the knot that it meets.
_LAST_DIGITS = 4e-15
# Share of f P within which a path runs along the curve that it unloads, and share within which a line goes straight on.
_ALONG, _STRAIGHT_ON = 8e-15, 1e-15
# Steps that are followed at a time: more are no faster, for the garbage collector sees all their records.
_BLOCK = 2000
# Quadrature nodes and cuts that are held at a time.
_CHUNK = 200_000
# Share of the whole path, and of a step, within which somebody else's instant is one of the path's own.
_SLACK, _SLACK_OF_STEP = 1e-9, 1e-6
# Rows beyond which a path is answered at its rows, with pointwise fields at some of them only.
MANY = 1000
_INSTANTS, _INSTANTS_OF_LOADING = 400, 100
# Nodes of Gauss' rule while P and P_c change by less than a share: 3e-13 by the distance of the singularity. Above, graded, which
# takes 193: a million rows would take ten times as long.
_RULE, _SAMPLE = 3e-13, 200
_RULES = ((0.05, 4), (0.3, 6), (0.6, 12), (0.9, 24))
# Half-widths over the largest: 7 % apart a root of dP/da at 0.73 +- 0.24 i leaves 4e-14 of W, 16 % apart 2e-11.
_LADDER = 2.0 ** -np.arange(0.1, 5.0, 0.1)
_NO_LEG = StraightSegment(0.0, 1.0, (0.0, 0.0), (0.0, 0.0))


# ------------------------------------------------------------------------------------------------- the curve and one step
class Knot(NamedTuple):
    """The uppermost line of a memory curve, and by `below` the whole curve; None for bodies out of contact.

    `load` and `force` are eta and M at its upper end, `length` and `rise` their growth along it, `depth` the number of lines.
    """

    below: Knot | None
    load: float
    force: float
    length: float
    rise: float
    depth: int


Station = tuple[float, float, float]
"""P, Q and the share of the step that is over."""
Rows = list[tuple[Knot | None, float, float, float, float, float, float, float]]
"""Records while steps are followed: the line of the memory that each goes through, then the columns of `Records`."""


def _step(curve: Knot | None, first: Station, last: Station, friction: float, records: Rows) -> Knot | None:
    """The curve after a straight step."""
    normal, tangential = last[0] - first[0], last[1] - first[1]
    limit = friction * normal
    noise = _NOISE * (abs(tangential) + abs(limit))
    forward, reverse = tangential - limit > noise, -tangential - limit > noise
    if normal < 0 and forward == reverse:
        return _unload(curve, first, last, friction, records)
    if forward or reverse:
        return _slip(curve, 1 if forward else -1, first, last, friction, records)
    if normal > 0:  # full stick
        below, length, rise = curve, normal, tangential
        if curve is not None:
            one, other = curve.rise * length, rise * curve.length
            if abs(one - other) <= _STRAIGHT_ON * (abs(one) + abs(other)):
                below, length, rise = curve.below, length + curve.length, rise + curve.rise
        curve = Knot(below, last[0], last[1], length, rise, below.depth + 1 if below is not None else 1)
    records.append((curve, 0, first[0], last[0], 0.0, 0.0, 0.0, last[2]))
    return curve


def _slip(curve: Knot | None, s: int, first: Station, last: Station, friction: float, records: Rows) -> Knot | None:
    """Slip in direction s: the front goes down through the lines, as far as the level rises."""
    (load, _, until), (normal, tangential, end), begin = first, last, first[2]
    growth = normal - load
    total = rest = s * (tangential - first[1]) - friction * growth
    digits = _LAST_DIGITS * friction * max(load, normal)
    slid = passed = part = length = 0.0
    # What slips already is at the limit, and the front is below it.
    if curve is not None and curve.below is not None and friction * curve.length <= s * curve.rise:
        slid = passed = curve.length
        curve = curve.below
    while curve is not None:
        below, top, force, length, rise, depth = curve
        needed = friction * length - s * rise
        # A front that meets a knot at the very end of the step, to rounding, has not passed it: what lies below may be at the limit
        # already, and the front would jump through it.
        if rest <= needed + digits or below is None:
            # |Q| <= f P was checked: what the lowest line has not room for is rounding.
            part = min(max(rest, 0.0) / needed, 1.0) if needed > 0 else 0.0
            break
        passed += length
        if needed > 0:
            rest -= needed
            share = 1 - rest / total
            after, slipped, until = first[0] + share * growth, passed + share * growth, begin + share * (end - begin)
            records.append((curve, s, load, after, slid, slipped, needed, until))
            load, slid = after, slipped
        else:
            slid += length
        curve = below
    slipped = passed + part * length + growth
    records.append((curve, s, load, normal, slid, max(slipped, 0.0), max(rest, 0.0), end))
    if part > 0:
        left = 1 - part
        curve = Knot(below, top - part * length, force - part * rise, left * length, left * rise, depth) if left > 0 else below
    if not slipped > 0:
        return curve
    return Knot(curve, normal, tangential, slipped, s * friction * slipped, curve.depth + 1 if curve is not None else 1)


def _unload(curve: Knot | None, first: Station, last: Station, friction: float, records: Rows) -> Knot | None:
    """P falls and |dQ| <= f |dP|: slip to the side of the curve on which the path runs, in parts where it crosses the curve.

    The admissible cones of later points lie inside those of earlier ones, so the state is that of one step.
    """
    drop, slope, noise = first[0] - last[0], (last[1] - first[1]) / (last[0] - first[0]), _ALONG * friction * first[0]
    runs: list[tuple[float, int]] = []  # (fall of P at the end, side) of each part
    down, above, before, line = 0.0, 0.0, 0, curve
    while line is not None and down < drop:
        step = min(line.length, drop - down)
        now = above + line.rise * (step / line.length) - slope * step
        side = 0 if abs(now) <= noise else (1 if now > 0 else -1)
        if side * before < 0:
            runs.append((down + step * above / (above - now), before))
        down += step
        here = side or before
        if runs and runs[-1][1] == here:
            runs.pop()
        runs.append((down, here))
        above, before, line = now, side, line.below
    begin = first
    for number, (fall, side) in enumerate(runs or [(drop, 0)], 1):
        share = first[2] + fall / drop * (last[2] - first[2])
        end = last if number >= len(runs) else (first[0] - fall, first[1] - slope * fall, share)
        curve = (_slip(curve, side, begin, end, friction, records)) if side else _along(curve, begin, end, records)
        begin = end
    return curve if last[0] > 0 else None


def _along(curve: Knot | None, first: Station, last: Station, records: Rows) -> Knot | None:
    """Unload along the curve itself: nothing slips."""
    drop = rest = first[0] - last[0]
    begin = first
    while curve is not None and rest > 0 and begin is not last:
        below, top, force, length, rise, depth = curve
        part, rest = rest / length, rest - length
        after = 1 - max(rest, 0.0) / drop
        end = last if below is None or rest <= 0 else (first[0] - after * drop, 0.0, first[2] + after * (last[2] - first[2]))
        records.append((curve, 0, begin[0], end[0], 0.0, 0.0, 0.0, end[2]))
        begin, left = end, 1 - part
        curve = Knot(below, top - part * length, force - part * rise, left * length, left * rise, depth) if left > 0 else below
    if begin is not last:
        records.append((curve, 0, begin[0], last[0], 0.0, 0.0, 0.0, last[2]))
    return curve


class Records(NamedTuple):
    """Parts of steps, (m,) each: direction of slip (0: none), P and P - P_c at both ends, rise of the level, share of the step that
    is over at the end, and `row`, the number of the step.
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

    def slipping(self) -> Records:
        """Those that slip."""
        return self.take(self.direction != 0)


class Block(NamedTuple):
    """What steps from row to row (n + 1, 2) leave: records, the line of each, the curve at the end, most lines alive."""

    rows: Array
    records: Records
    lines: tuple[Knot | None, ...]
    curve: Knot | None
    alive: int


def follow(curve: Knot | None, rows: Array, friction: float) -> Block:
    """Straight steps from the first of `rows` (n + 1, 2) of P and Q, where the memory is `curve`, to each of the others.

    >>> block = follow(None, np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [2.0, -0.5]]), 0.5)
    >>> block.records.slipped_after.tolist(), block.alive  # Q/f, then (Q - Q')/(2 f)
    ([0.0, 1.0, 1.0], 2)
    """
    records: Rows = []
    counts, alive = [0], 0
    p, q = rows[0].tolist()
    for normal, tangential in rows[1:].tolist():
        curve = _step(curve, (p, q, 0.0), (normal, tangential, 1.0), friction, records)
        p, q = normal, tangential
        counts.append(len(records))
        if curve is not None and curve.depth > alive:
            alive = curve.depth
    lines, *columns = zip(*records, strict=True)
    table = [*(np.array(column, dtype=float) for column in columns), np.repeat(np.arange(len(rows) - 1), np.diff(counts))]
    return Block(rows, Records._make(table), lines, curve, alive)


def knots_of(curve: Knot | None) -> tuple[Array, Array]:
    """(eta, M) of the knots, ascending from (0, 0)."""
    points = [(0.0, 0.0)]
    while curve is not None:
        points.insert(1, (curve.load, curve.force))
        curve = curve.below
    loads, forces = np.array(points).T
    return loads, forces


# ------------------------------------------------------------------------------------------------------ the whole path
class Part(NamedTuple):
    """A part of a path: rows (m + 1, 3) of time, P and Q, what makes their time the path's, the memory at the first row."""

    rows: Array
    delay: float
    curve: Knot | None


@dataclass(frozen=True, eq=False)
class LoadSeries:
    """A path of straight steps that has been followed.

    Attributes
    ----------
    friction : f
    loading : initial loading, None where the path has no period
    cycles : each solved cycle; the whole path where it has no period
    period : duration of a cycle, None for a path that does not repeat
    covered : for each whole cycle that the answer covers, the index of the solved cycle that it is or is a copy of
    steady_from : index of the first cycle that ends in the state it started from, None if none did
    repeats : whether cycles after that one are copies
    """

    friction: float
    loading: Part | None
    cycles: tuple[Part, ...]
    period: float | None
    covered: tuple[int, ...]
    steady_from: int | None
    repeats: bool = True

    @property
    def parts(self) -> tuple[Part, ...]:
        """All of them in the order of time."""
        return self.cycles if self.loading is None else (self.loading, *self.cycles)

    @property
    def largest(self) -> float:
        """The largest P."""
        return max(float(np.max(part.rows[:, 1])) for part in self.parts)

    @property
    def long(self) -> bool:
        """Whether the path is answered at its rows."""
        return max(len(part.rows) for part in self.parts) > MANY

    def blocks(self, part: Part) -> Iterator[tuple[int, Block]]:
        """The steps of a part, a block at a time, and the number of the first."""
        curve = part.curve
        for first in range(0, len(part.rows) - 1, _BLOCK):
            block = follow(curve, part.rows[first : first + _BLOCK + 1, 1:], self.friction)
            yield first, block
            curve = block.curve

    def default_times(self, steady: bool, few: bool) -> tuple[Array, int]:
        """Instants where none are asked for, and how many rows of a long path are left out where a `few` will do.

        About 400 a cycle, evenly spread over each record, both its ends among them; of a long path the rows.
        """
        parts = self.parts[-1:] if steady else self.parts
        if self.long:
            rows = np.concatenate([parts[0].rows[:1, 0] + parts[0].delay, *(part.rows[1:, 0] + part.delay for part in parts)])
            chosen = rows[:: max(len(rows) // _INSTANTS, 1) if few else 1]
            chosen = chosen if chosen[-1] == rows[-1] else np.append(chosen, rows[-1])
            return chosen, len(rows) - len(chosen)
        times = []
        for part in parts:
            count = _INSTANTS_OF_LOADING if part is self.loading else _INSTANTS
            marks = self._marks(part)
            share = np.diff(marks) / (marks[-1] - marks[0])
            for begin, end, number in zip(marks[:-1], marks[1:], np.maximum(np.ceil(count * share), 2), strict=True):
                times.append(np.linspace(begin, end, int(number) + 1) + part.delay)
        return np.unique(np.concatenate(times)), 0

    def _marks(self, part: Part) -> Array:
        """Times at which records begin and end, ascending."""
        times = [part.rows[:1, 0]]
        for first, block in self.blocks(part):
            before = part.rows[first + block.records.row, 0]
            after = part.rows[first + block.records.row + 1, 0]
            times.append(np.where(block.records.until == 1, after, before + block.records.until * (after - before)))
        return np.unique(np.concatenate(times))

    def locate(self, time: Array) -> tuple[Indices, Indices, Array, Array]:
        """Numbers of part and step, share of the step that is over, and share within which two instants are one: (n,) each.

        An instant between two steps belongs to the one that ends there.

        Raises
        ------
        InputError
            For a time outside the path.
        """
        parts = self.parts
        start, ends = parts[0].rows[0, 0] + parts[0].delay, np.array([part.rows[-1, 0] + part.delay for part in parts])
        slack, inside = _SLACK * (ends[-1] - start), time
        if self.period is not None:
            inside = time - self.period * np.maximum(np.ceil((time - ends[-1] - slack) / self.period), 0.0)
        if np.any(inside < start - slack) or np.any(inside > ends[-1] + slack):
            raise InputError(f"time: outside the load path, which runs from {start:.6g} to {ends[-1]:.6g}")
        number = np.minimum(np.searchsorted(ends, inside - slack, side="left"), len(parts) - 1)
        step, share, near = np.zeros(len(time), dtype=np.int64), np.zeros(len(time)), np.zeros(len(time))
        for k in np.unique(number):
            here, times = np.flatnonzero(number == k), parts[k].rows[:, 0]
            at = np.clip(inside[here] - parts[k].delay, times[0], times[-1])
            row = np.clip(np.searchsorted(times, at, side="left"), 1, len(times) - 1)
            allowed = np.minimum(slack / (times[row] - times[row - 1]), _SLACK_OF_STEP)
            # A row that somebody else found to rounding is still the row.
            row = np.where((row > 1) & (at - times[row - 1] <= allowed * (times[row] - times[row - 1])), row - 1, row)
            near[here] = np.minimum(slack / (times[row] - times[row - 1]), _SLACK_OF_STEP)
            part = (at - times[row - 1]) / (times[row] - times[row - 1])
            step[here], share[here] = row - 1, np.where(part > 1 - near[here], 1.0, part)
        return number, step, share, near


def is_straight(path: LoadPath) -> bool:
    """Whether all legs are straight lines: on any other some sum of P and Q turns round."""
    return all(leg.most_turns == 0 for leg in (*path.way_in, *path.cycle))


def own_series(scene: Scene, time: Array | None) -> LoadSeries | None:
    """The scene's own path, None where it is not straight: as many cycles as `time` needs; until it is steady where it needs none.

    Raises
    ------
    InadmissibleLoadError
        For gross sliding or separation, with the instant and the loads.
    """
    friction, load = scene.friction.coefficient, scene.load
    if isinstance(load, TimeSeriesLoad):  # a leg for each of a million rows would take a gigabyte
        rows = load.series()
        loading, cycle = (rows[:2], rows[1:]) if load.repeats else (rows, rows[-1:])
    else:
        path = load.path()
        if not is_straight(path):
            return None
        loading, cycle = _rows_of(path.way_in), _rows_of(path.cycle) if path.cycle else np.empty((1, 3))
    check_rows(loading, friction)
    if len(cycle) < 2:
        steady = 0 if loading[-1, 1] <= 0 else None
        return LoadSeries(friction, None, (Part(loading, 0.0, None),), None, (0,), steady, repeats=False)
    check_rows(cycle, friction)
    period = float(cycle[-1, 0] - cycle[0, 0])
    most, whole = turns_of(float(cycle[0, 0]), period, scene.cycles, time)
    turns = (Part(cycle, k * period, None) for k in range(most))
    return _followed(friction, Part(loading, 0.0, None), turns, period, whole)


def straight_series(path: LoadPath, friction: float, time: Array) -> LoadSeries:
    """Straight lines between the path's points at `time`, ascending; from (0, 0) to the first of them too.

    A revolution that starts between two of the times starts on the straight line between them.
    """
    if np.any(np.diff(time) <= 0):
        raise InputError("straight_steps: the times must ascend, no two of them equal")
    times = np.concatenate([[path.start], time]) if float(time[0]) > path.start else time
    rows = np.stack([times, *path.at(times)], axis=1)
    if path.period is None:
        check_rows(rows, friction)
        return LoadSeries(friction, None, (Part(rows, 0.0, None),), None, (0,), 0 if rows[-1, 1] <= 0 else None, repeats=False)
    slack = _SLACK * path.period
    whole = max(math.floor((float(times[-1]) - path.cycle_start) / path.period + _SLACK), 0)
    marks = path.cycle_start + path.period * np.arange(whole + 1)
    near = np.abs(times[:, None] - marks) <= slack
    every = np.sort(np.concatenate([times, marks[~near.any(axis=0) & (marks < times[-1])]]))
    rows = np.stack([every, *(np.interp(every, times, rows[:, k]) for k in (1, 2))], axis=1)
    check_rows(rows, friction)
    cuts = np.flatnonzero(np.diff(np.searchsorted(marks - slack, every[:-1], side="right"), prepend=0))
    bounds = [0, *cuts.tolist(), len(every) - 1]
    loading, *turns = (Part(rows[a : b + 1], 0.0, None) for a, b in pairwise(bounds))
    if not turns:
        return LoadSeries(friction, None, (loading,), path.period, (0,), None, repeats=False)
    return _followed(friction, loading, turns, path.period, whole, repeats=False)


def _rows_of(legs: Sequence[LoadSegment]) -> Array:
    """Time, P and Q at the ends of legs: (m + 1, 3)."""
    stations = [(legs[0].start, legs[0]), *((leg.end, leg) for leg in legs)]
    return np.array([[time, *(float(load) for load in leg.loads(time))] for time, leg in stations])


def check_rows(rows: Array, friction: float) -> None:
    """Raise InadmissibleLoadError at the first gross sliding or separation; lines between admissible points are admissible."""
    normal, tangential = rows[:, 1], rows[:, 2]
    slack = _NOISE * float(np.max(np.abs(normal)))
    bad = np.flatnonzero((normal < -slack) | (np.abs(tangential) > friction * (normal + slack)))
    if len(bad):
        before, after = rows[max(int(bad[0]) - 1, 0)].tolist(), rows[bad[0]].tolist()
        leg = StraightSegment(before[0], after[0], (before[1], before[2]), (after[1], after[2]))
        check([leg], friction)
        raise InadmissibleLoadError("separation" if after[1] < -slack else "gross sliding", after[0], after[1], after[2], friction)


def _followed(
    friction: float, loading: Part, turns: Iterable[Part], period: float, whole: int, *, repeats: bool = True
) -> LoadSeries:
    """The series whose `turns` come one after the other; where they repeat, up to the first that ends as it began."""
    series = LoadSeries(friction, loading, (), period, (0,), None, repeats)
    largest = float(np.max(loading.rows[:, 1]))
    cycles, steady, curve = [], None, loading.curve
    for _, block in series.blocks(loading):
        curve = block.curve
    for number, turn in enumerate(turns):
        cycles.append(turn._replace(curve=curve))
        deepest, largest = 0.0, float(np.max(turn.rows[:, 1]))
        for _, block in series.blocks(cycles[-1]):
            curve, slipped = block.curve, block.records
            deepest = max(deepest, float(np.max(np.maximum(slipped.slipped, slipped.slipped_after), initial=0.0)))
        if steady is None and _alike(cycles[-1].curve, curve, friction, repeats_within(deepest / largest)):
            steady = number
            if repeats:
                break
    covered = tuple(min(number, len(cycles) - 1) for number in range(whole or (len(cycles) if repeats else 1)))
    return replace(series, cycles=tuple(cycles), covered=covered, steady_from=steady)


def _alike(one: Knot | None, other: Knot | None, friction: float, tolerance: float) -> bool:
    """Whether two curves agree within `tolerance` f P at the knots of both."""
    curves = [knots_of(curve) for curve in (one, other)]
    knots = np.union1d(curves[0][0], curves[1][0])
    first, second = (np.interp(knots, *curve) for curve in curves)
    same = abs(curves[0][0][-1] - curves[1][0][-1]) <= tolerance * knots[-1]
    return bool(same and np.all(np.abs(first - second) <= tolerance * friction * knots[-1]))


# ------------------------------------------------------------------------------------------------ friction work of records
Values = Callable[[Indices, Array, Array], Array]
"""Something along records number (n,) at P and P - P_c (n, k): (n, k)."""


def _means(contact: Contact, records: Records, values: Values) -> tuple[Array, int]:
    """Mean of `values` along each record, (m,), and how many nodes it took.

    P and P_c are linear along a record. The integrand is singular where either would be 0, beyond an end, if they went on, and
    where it would be at the corner below: as d^(3/2) only, which nodes that crowd to both ends resolve.
    """
    corners = corner_loads(contact)
    cuts = _cuts(contact, records)
    result, nodes, size = np.zeros(len(records.row)), 0, max(_CHUNK // (2 * len(cuts) + 1), 1)
    for first in range(0, len(records.row), size):
        some = records.take(slice(first, first + size))
        which, low, high = _split(some, cuts)
        load, fall = some.load[which], (some.load_after - some.load)[which]
        slid, slip = some.slipped[which], (some.slipped_after - some.slipped)[which]
        ends = [tuple(begin + at * growth for at in (low, high)) for begin, growth in ((load, fall), (load - slid, fall - slip))]
        share, behind = (
            np.maximum(*(_share(np.minimum(*pair), np.maximum(*pair), base) for pair in ends)) for base in (np.empty(0), corners)
        )
        crowded = behind > np.maximum(share, _RULES[0][0])
        rules = [*((gauss(count), (share > before) & (share <= limit) & ~crowded) for before, limit, count in _limits())]
        rules.append((_CROWDED, crowded & (share <= _RULES[-1][0])))
        rules.append(((ROOTS.up, ROOTS.share), share > _RULES[-1][0]))
        for (part, weight), chosen in rules:
            every = np.flatnonzero(chosen)
            nodes += len(every) * len(part)
            for k in range(0, len(every), _CHUNK // len(part) + 1):
                here = every[k : k + _CHUNK // len(part) + 1]
                at = low[here, None] + (high - low)[here, None] * part
                p = load[here, None] + fall[here, None] * at
                d = np.clip(slid[here, None] + slip[here, None] * at, 0.0, p)
                mean = (high - low)[here] * np.sum(weight * values(first + which[here], p, d), axis=1)
                result[first : first + size] += np.bincount(which[here], mean, len(some.row))
    return result, nodes


def _limits() -> Iterator[tuple[float, float, int]]:
    """(share above, share up to, nodes) of Gauss' rules."""
    before = -1.0
    for limit, count in _RULES:
        yield before, limit, count
        before = limit


def _crowding(count: int) -> tuple[Array, Array]:
    """Gauss' rule in t on [0, 1] of 3 t^2 - 2 t^3."""
    t, weight = gauss(count)
    return t * t * (3 - 2 * t), weight * 6 * t * (1 - t)


_CROWDED = _crowding(24)


def _share(low: Array, high: Array, corners: Array) -> Array:
    """How much of the way to the corner below `high`, or to 0, a range takes: 1 - low/high counted from there."""
    base = np.append(0.0, corners)[np.searchsorted(corners, (low + high) / 2)]
    return 1 - np.maximum(low - base, 0.0) / np.maximum(high - base, np.finfo(float).tiny)


def _cuts(contact: Contact, records: Records) -> Array:
    """Loads of corners and, where P may hardly grow anywhere, of half-widths so close that a(P) is smooth in between."""
    corners = corner_loads(contact)
    if not bends_anywhere(contact) or not len(records.row):
        return corners
    largest = contact.half_width(max(float(np.max(records.load)), float(np.max(records.load_after))))
    return np.append(corners, contact.load(largest * _LADDER))


def _split(records: Records, cuts: Array) -> tuple[Indices, Array, Array]:
    """Parts of the records between which P and P_c pass none of some loads: number of the record, begin and end as shares of it."""
    shares = [np.zeros((len(records.row), 1))]
    for begin, end in (
        (records.load, records.load_after),
        (records.load - records.slipped, records.load_after - records.slipped_after),
    ):
        growth = (end - begin)[:, None]
        shares.append(np.clip((cuts - begin[:, None]) / np.where(growth != 0, growth, np.inf), 0.0, 1.0))
    low = np.sort(np.concatenate(shares, axis=1), axis=1)
    high = np.append(low[:, 1:], np.ones((len(low), 1)), axis=1)
    which, number = np.nonzero(high > low)
    return which, low[which, number], high[which, number]


def slip_work(contact: Contact, records: Records) -> tuple[Array, int]:
    """int Lam dw of each record of slip, (m,) [force^2 per thickness^2], and how many nodes it took."""
    means, nodes = _means(contact, records, lambda _, load, slipped: contact.log_area(load, slipped))
    return records.rise * means, nodes


def work_error(contact: Contact, records: Records) -> float:
    """Error of the sum of `slip_work` from above, by a sample of records; 0 for closed forms [force^2 per thickness^2]."""
    if contact.closed_form or not len(records.row):
        return 0.0
    some = records.take(np.unique(np.linspace(0, len(records.row) - 1, _SAMPLE).astype(int)))
    load, slipped = np.append(some.load, some.load_after), np.append(some.slipped, some.slipped_after)
    left = contact.quadrature_error("log_area", load, slipped) + _RULE * contact.log_area(load, slipped)
    if not np.all(np.isfinite(left)):
        raise NotFoundError("the error of a slip area is not a number: neither is the dissipation of these rows")
    return float(np.max(left, initial=0.0) * np.sum(records.rise))


def density_of_records(contact: Contact, records: Records, x: Array) -> Array:
    """int p arccosh(|x|/c) dw of all records of slip at |x| = `x` (k,): shape (k,) [stress * force per thickness]."""
    edge, total, cuts = contact.load(x), np.zeros(len(x)), _cuts(contact, records)
    size = max(_CHUNK // (len(x) * (2 * len(cuts) + 1)), 1)
    for first in range(0, len(records.row), size):
        some = records.take(slice(first, first + size))
        which, low, high = _split(some, cuts)
        load, fall = some.load[which], (some.load_after - some.load)[which]
        slid, slip = some.slipped[which], (some.slipped_after - some.slipped)[which]
        begin, end = _slip_shares(load + low * fall, load + high * fall, slid + low * slip, slid + high * slip, edge)
        number, point = np.nonzero(end > begin)
        for j in range(0, len(number), _CHUNK // NODES):
            n, i = number[j : j + _CHUNK // NODES], point[j : j + _CHUNK // NODES]
            part, weight = graded(begin[n, i], end[n, i])
            at = low[n, None] + (high - low)[n, None] * part
            p, d = load[n, None] + fall[n, None] * at, slid[n, None] + slip[n, None] * at
            reach = contact.reach(x[i, None], np.maximum(edge[i, None] - (p - d), 0.0), p - d)
            work = (some.rise[which] * (high - low))[n] * np.sum(weight * contact.pressure(x[i, None], p) * reach, axis=1)
            total += np.bincount(i, work, len(x))
    return total


def _slip_shares(load: Array, load_after: Array, slipped: Array, slipped_after: Array, edge: Array) -> tuple[Array, Array]:
    """Between which shares of ranges (m, k) points of edge load (k,) are in contact and outside the front."""
    front = (load - slipped)[:, None]
    drop, growth = front - (load_after - slipped_after)[:, None], (load_after - load)[:, None]
    begin = np.clip((front - edge) / np.where(drop > 0, drop, 1.0), 0.0, 1.0)
    begin = np.where(edge >= front, 0.0, np.where(drop > 0, begin, 1.0))
    meets = np.clip((edge - load[:, None]) / np.where(growth != 0, growth, 1.0), 0.0, 1.0)
    inside = edge < np.maximum(load, load_after)[:, None]
    end = np.where(inside, np.where(growth < 0, meets, 1.0), 0.0)
    return np.where(growth > 0, np.maximum(begin, meets), begin), end


class Loop:
    """Closed integral of Q dU over records, one block after another.

    Written as -int U dQ with a datum of the logarithm for which it is nothing where the contact is largest: that adds a multiple of
    the integral of Q dQ, which vanishes, and keeps the digits where a hardly varies, as for a face that is nearly all flat. With
    G = int_0^P ln(2 L/a) d eta and the slope m of the line that a record goes through, U over A/pi grows along it by m times the
    growth of G(P_c) plus s f times that of G(P) - G(P_c).
    """

    def __init__(self, contact: Contact, friction: float, largest: float) -> None:
        self.contact = replace(contact, datum_length=float(contact.half_width(largest)) / 2)
        self.friction, self.largest = friction, largest
        self.shift = self.value = self.travel = 0.0

    def add(self, records: Records, lines: Sequence[Knot | None]) -> None:
        slope = np.array([line.rise / line.length if line is not None else 0.0 for line in lines])
        limit = records.direction * self.friction

        def moved(which: Indices, load: Array, slipped: Array) -> Array:
            shape = (len(which), *(1,) * (load.ndim - 1))
            whole = self.contact.log_distance(load)
            front = np.where(slipped > 0, self.contact.log_distance(np.maximum(load - slipped, 0.0)), whole)
            return slope[which].reshape(shape) * front + limit[which].reshape(shape) * (whole - front)

        every = np.arange(len(slope))
        begin, end = (
            moved(every, *pair) for pair in ((records.load, records.slipped), (records.load_after, records.slipped_after))
        )
        growth = records.load_after - records.load
        force = np.where(
            records.direction == 0, slope * growth, records.direction * (records.rise + self.friction * growth)
        )  # along a record
        before = self.shift + np.cumsum(end - begin) - (end - begin)
        self.value -= float(np.sum(force * (before + _means(self.contact, records, moved)[0] - begin)))
        self.shift += float(np.sum(end - begin))
        self.travel += float(np.sum(np.abs(force)))

    @property
    def rounding(self) -> float:
        """What the last digits of U may have left: U is a sum of logarithms times loads up to f P, however little of it changes."""
        size = 2 * abs(float(self.contact.log_distance(self.largest)))
        return DIGITS_OF_SHIFT * self.friction * size * self.travel


# ------------------------------------------------------------------------------------------------ what an answer needs
class States:
    """The memory curves of instants, collected block by block; the lines that they share become pieces once."""

    def __init__(self, friction: float, curves: bool) -> None:
        self.friction, self.curves = friction, curves
        self._columns: list[tuple[NDArray[Any], ...]] = []
        self._pieces: list[Curve] = []
        self._known: dict[int, tuple[Knot, Curve]] = {}

    def add(self, block: Block, step: Indices, share: Array, near: Array) -> None:
        """Instants (n,) at shares of steps of a block; `near` is how far a share may miss the end of a record."""
        if not len(step):
            return
        records = block.records
        ends = np.minimum(np.searchsorted(records.row + records.until, step + share - near, side="left"), len(records.row) - 1)
        ends = np.where(records.row[ends] < step, ends + 1, ends)
        begin = np.where(np.diff(records.row, prepend=-1) > 0, 0.0, np.append(0.0, records.until[:-1]))[ends]
        part = np.clip((share - begin) / np.maximum(records.until[ends] - begin, np.finfo(float).tiny), 0.0, 1.0)
        before, after = block.rows[step], block.rows[step + 1]
        later = (share > 0.5)[:, None]
        load, force = np.where(later, after - (1 - share)[:, None] * (after - before), before + share[:, None] * (after - before)).T
        load = np.maximum(load, 0.0)  # a path that unloads fully may end below 0 by rounding
        used, which = np.unique(ends, return_inverse=True)
        lines = [block.lines[k] for k in used]
        top, held, slope, bottom = np.array([_ends_of(line) for line in lines])[which].T
        slipped = records.slipped[ends] + part * (records.slipped_after - records.slipped)[ends]
        slips = records.direction[ends] != 0
        slipped = np.where(slips, np.clip(slipped, np.maximum(load - top, 0.0), np.maximum(load - bottom, 0.0)), 0.0)
        balance = held - slope * (top - (load - slipped)) + records.direction[ends] * self.friction * slipped - force
        self._columns.append((load, force, slipped, records.direction[ends], which + len(self._pieces), balance))
        if self.curves:
            self._pieces += [self._piece(line) for line in lines]

    def _piece(self, line: Knot | None) -> Curve:
        """The curve of fields' integrals; what is below a line is made once."""
        chain = []
        while line is not None and id(line) not in self._known:
            chain.append(line)
            line = line.below
        made = self._known[id(line)][1] if line is not None else None
        for each in reversed(chain):
            made = Piece(made, each.load, Instant(_NO_LEG, math.nan, each.load, each.force), each.rise / each.length)
            self._known[id(each)] = (each, made)
        return made

    def snapshot(self, time: Array, back: Indices) -> tuple[Snapshot, Array]:
        """All of them in the order of `time`, and M(P) - Q."""
        load, force, slipped, direction, which, balance = (
            np.concatenate(column)[back] for column in zip(*self._columns, strict=True)
        )
        if not self.curves:
            which = np.zeros(len(time))
        pieces = tuple(self._pieces) or (None,)
        columns = (time, load, force, slipped, direction.astype(np.int64), which.astype(np.intp))
        return Snapshot(*columns, pieces, self.friction), balance


def _ends_of(line: Knot | None) -> tuple[float, float, float, float]:
    """eta and M at the upper end of a line, its slope, eta at the lower end."""
    if line is None:
        return 0.0, 0.0, 0.0, 0.0
    return line.load, line.force, line.rise / line.length, line.below.load if line.below is not None else 0.0


def along_series(series: LoadSeries, request: Request) -> Along:
    """States at the instants of the request and the friction work of the cycles; parts are followed once more where it is needed.

    Raises
    ------
    InputError
        For a time outside the path.
    """
    contact, fields, friction = request.contact, request.fields, series.friction
    unit, first = 2 / (math.pi * request.modulus), 0 if series.loading is None else 1
    factor = unit * friction
    number, step, share, near = series.locate(request.time)
    order = np.lexsort((share, step, number))
    number, step, share, near = number[order], step[order], share[order], near[order]
    back, last, whole = np.argsort(order), series.covered[-1] + first, "dissipation" in fields
    pointwise = "dissipation_density" in fields
    worked = {k + first for k in series.covered} if whole else set()
    at_rows = whole and bool(np.all((share == 1) | ((share == 0) & (step == 0) & (number == 0))))
    if at_rows:  # the work of every row is on record
        worked = set(range(len(series.parts)))
    # Over a million rows the closed integral would cost as much as all the rest.
    closed = whole and not series.long and series.steady_from is not None and series.covered[-1] >= series.steady_from
    loop = Loop(contact, friction, series.largest) if closed else None
    states = States(friction, not fields.isdisjoint(("shear", "slip", "rigid_shift")))
    works, errors, deepest = (np.zeros(len(series.parts)) for _ in range(3))
    each: list[NDArray[Any]] = [np.zeros(1)]
    density, least, stick = np.zeros(len(request.distance)), math.inf, 0
    counts = dict.fromkeys(("spans", "slips", "pieces_alive", "pieces_dropped", "slip_quadratures", "quadrature_nodes"), 0)
    for k, part in enumerate(series.parts):
        here = slice(*np.searchsorted(number, [k, k + 1]).tolist())
        if here.start == here.stop and k not in worked and k != last:
            continue
        alive = part.curve.depth if part.curve is not None else 0
        for begin, block in series.blocks(part):
            records, slips, steps = block.records, block.records.slipping(), len(block.rows) - 1
            some = slice(*(here.start + np.searchsorted(step[here], [begin, begin + steps])).tolist())
            states.add(block, step[some] - begin, share[some], near[some])
            integrals = (k in worked) + (pointwise and k == last)
            counts["spans"] += len(records.row)
            counts["slips"] += len(slips.row)
            counts["slip_quadratures"] += integrals * len(slips.row)
            stick += integrals * (len(records.row) - len(slips.row))
            left = block.curve.depth if block.curve is not None else 0
            counts["pieces_dropped"] += steps + alive - left  # each step puts one on
            counts["pieces_alive"], alive = max(counts["pieces_alive"], block.alive), left
            deepest[k] = max(deepest[k], float(np.max(np.maximum(slips.slipped, slips.slipped_after), initial=0.0)))
            if k in worked:
                work, nodes = slip_work(contact, slips)
                works[k] += factor * float(np.sum(work))
                errors[k] += factor * work_error(contact, slips)
                counts["quadrature_nodes"] += nodes
                if at_rows:
                    each.append(factor * np.bincount(slips.row, work, steps))
            if k == last:
                fronts = (records.load - records.slipped, records.load_after - records.slipped_after)
                least = min(least, *(float(np.min(front)) for front in fronts))
                if pointwise:
                    density += factor * density_of_records(contact, slips, request.distance)
                if loop is not None:
                    loop.add(records, block.lines)
    shares = deepest / np.array([float(np.max(part.rows[:, 1])) for part in series.parts])
    rounding = np.array([3 * rounding_of_slip(share) for share in shares.tolist()])
    errors = np.divide(errors, works, out=np.zeros(len(works)), where=works > 0) + rounding
    covered = [k + first for k in series.covered]
    starts = np.concatenate([[0], np.cumsum([len(part.rows) - 1 for part in series.parts])])
    so_far = np.cumsum(np.concatenate(each))[(starts[number] + step + (share == 1))[back]] if at_rows else np.empty(0)
    snapshot, balance = states.snapshot(request.time, back)
    return Along(
        snapshot=snapshot,
        balance=balance,
        least=least,
        slipped_share=float(np.max(shares)),
        each=works[covered] if whole else np.full(len(covered), math.nan),
        each_error=float(np.max(errors[covered])) if whole else 0.0,
        density=density if pointwise else np.full(len(density), math.nan),
        density_error=rounding[last] if pointwise else 0.0,
        loop=(unit * loop.value, unit * loop.rounding) if loop is not None else None,
        spans=(),
        increments=np.diff(so_far, prepend=so_far[:1]),
        counts={
            "rows": sum(len(part.rows) - 1 for part in series.parts) + 1,
            **counts,
            "curves": len(snapshot.actives) if states.curves else 0,
        },
        stick=stick,
    )
