"""Curved paths: which part of a leg sticks, which slips, which piece of the memory is being erased,
and when (Masing rule).

A history is a sequence of spans, in each of which the memory curve keeps its structure. An
uppermost piece, `sticking_piece`, goes up to a load that moves with time: the load itself while P
follows the piece, the load P_c of the stick edge in slip. What lies below it is untouched. In slip
a line of slope +-f goes from there to (P, Q). Everything that is asked of a history later is
evaluated span by span, for many instants at once. Any path can be followed so; paths that are
straight all along take `load_series`, which costs less.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import ArrayLike

from scenes import (
    NORMAL_LOAD,
    Combination,
    InadmissibleLoadError,
    InputError,
    LoadedInstant,
    LoadPath,
    LoadSegment,
)
from scenes.array_types import Array
from semi_analytic.memory import (
    Curve,
    Instant,
    Piece,
    Snapshot,
    change_from,
    flat,
    instant,
    level,
    level_on,
    load_in_stick,
    pieces,
    repeats_within,
    same,
    slip_to,
    slipped_load,
    unload_to,
    value_on,
)
from semi_analytic.profiles import Contact

# Share of the largest load, or of the rates of P and Q, below which a difference is rounding.
_ROUNDING = 1e-14
# Share of a stretch of time, or of a level, within which two instants are one.
_NEAR = 1e-14
# Share of f P by which a front may miss the end of the piece that it meets, and of a time to which
# a crossing is found.
_LAST_DIGITS = 2e-15
# Instants at which a piece without a formula for its crossings is looked at.
_SAMPLES = 33
# Instants of a cycle and of the initial loading where none are asked for.
_INSTANTS = 400
_INSTANTS_OF_LOADING = 100
# Histories that are kept while `histories_kept` holds, by path and friction, then by the most
# cycles that were followed.
_Kept = dict[tuple[LoadPath, float], dict[int, "History"]]
_kept_histories: ContextVar[_Kept | None] = ContextVar("histories", default=None)
# Share of a cycle, or of the whole path, within which somebody else's instant is one of the path's
# own.
SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class Span:
    """A span of time in which the memory curve keeps its structure.

    Attributes
    ----------
    begin, end
        its ends on the load path, in the time of the leg
    delay
        what makes the leg's time the history's time
    direction
        +1 forward slip, -1 reverse slip, 0 no slip
    sticking_piece
        the uppermost piece that is left below the line of slip; None if the front is at P_c = 0
    friction
        f
    """

    begin: Instant
    end: Instant
    delay: float
    direction: int
    sticking_piece: Curve
    friction: float

    @property
    def leg(self) -> LoadSegment:
        """The leg of the load path that is being travelled."""
        return self.begin.leg

    def slipped(self, time: ArrayLike) -> Array:
        """P - P_c >= 0 at times of the leg; 0 where nothing slips."""
        t = np.asarray(time, dtype=float)
        return self.slipped_at(t, self.leg.loads(t)[0])

    def slipped_at(self, t: Array, load: Array) -> Array:
        """The same where P is known."""
        if self.direction == 0:
            return np.zeros(t.shape)
        if self.sticking_piece is None:
            return load
        lag = slipped_load(self.sticking_piece, self.direction, self.friction, self.leg, t)
        least_lag = np.maximum(load - self.sticking_piece.top, 0.0)
        largest_lag = load - self.sticking_piece.bottom
        # of a single number two calls take a quarter of the time of `clip`
        return np.minimum(np.maximum(lag, least_lag), largest_lag)

    @cached_property
    def deepest(self) -> float:
        """Largest P - P_c at its ends and half-way; 0 where nothing slips."""
        if not self.direction:
            return 0.0
        return float(np.max(self.slipped(np.linspace(self.begin.time, self.end.time, 3))))

    def curve(self, time: float) -> Curve:
        """The memory curve at a time of the leg."""
        point = instant(self.leg, time)
        if self.direction == 0:
            return unload_to(self.sticking_piece, point.normal)
        return slip_to(
            self.sticking_piece, self.direction, self.friction, point, float(self.slipped(time))
        )


def check(legs: Sequence[LoadSegment], friction: float) -> None:
    """Refuse a load path on which the contact slides as a whole, |Q| > f P, or separates, P < 0:
    InadmissibleLoadError at the first such instant of the segments `legs`.

    |Q| = f P is admitted, to 1e-14 of f times the largest load: in any unit, for any f.

    >>> from scenes import StraightSegment
    >>> check(
    ...     [StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.5))], 0.5
    ... )  # |Q| = f P is reached at the end, not exceeded
    >>> check([StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.6))], 0.3)
    Traceback (most recent call last):
    scenes.errors.InadmissibleLoadError: load: gross sliding from time 0.5 on, at time 1 with P = 1,
    Q = 0.6, f = 0.3: ...
    >>> check([StraightSegment(0.0, 1.0, (1.0, 0.0), (-1.0, 0.0))], 0.3)
    Traceback (most recent call last):
    scenes.errors.InadmissibleLoadError: load: separation from time 0.5 on, at time 1 with P = -1, Q
    = 0: ...
    """
    largest_load = max(
        abs(float(segment.loads(time)[0]))
        for segment in legs
        for time in (segment.start, segment.end)
    )
    for segment in legs:
        for begin_time, end_time in monotonic_parts(segment, friction):
            _check_part(segment, begin_time, end_time, friction, _ROUNDING * largest_load)


def _check_part(
    segment: LoadSegment, begin: float, end: float, friction: float, slack: float
) -> None:
    """Refuse a part of a load segment on which |Q| > f P or P < 0 somewhere: InadmissibleLoadError
    at the first such instant.

    P, Q - f P and Q + f P are monotonic on the part, so that its end is beyond a limit if anything
    is. P may be beyond its limit by `slack` [force per thickness]. The error also names the end of
    the part.
    """
    end_instant = instant(segment, end)
    excesses = [(NORMAL_LOAD, -end_instant.normal, "separation", slack)]
    for direction in (1, -1):
        excess = direction * end_instant.tangential - friction * end_instant.normal
        excesses.append((level(direction, friction), excess, "gross sliding", slack * friction))
    faults = []
    for combination, excess, reason, tolerance in excesses:
        if excess > tolerance:
            sign_of_growth = -1.0 if combination is NORMAL_LOAD else 1.0
            change_to_limit = sign_of_growth * float(segment.change_of(combination, end, begin))
            time = float(
                segment.time_of(
                    combination, sign_of_growth * (change_to_limit - excess), begin, end
                )
            )
            faults.append((time, reason))
    if faults:
        # Where P runs out both limits of friction are met at the same instant: that is separation.
        end_of_first_time = min(time for time, _ in faults) + _NEAR * (end - begin)
        time, reason = next(fault for fault in faults if fault[0] <= end_of_first_time)
        fault_instant = instant(segment, time)
        raise InadmissibleLoadError(
            reason,
            LoadedInstant(time, fault_instant.normal, fault_instant.tangential),
            # P, u and v are monotonic up to there
            LoadedInstant(end_instant.time, end_instant.normal, end_instant.tangential),
            friction=friction,
        )


def monotonic_parts(segment: LoadSegment, friction: float) -> list[tuple[float, float]]:
    """Begin and end times of the parts of a load segment between turning points of P, of u = Q - f
    P and of v = Q + f P.

    Where u rises the contact may slip forward, where v falls in reverse; f is `friction`.

    >>> from math import pi
    >>> from scenes import ellipse_segment
    >>> circle = ellipse_segment(0.0, 2 * pi, (3.0, 0.0), (1.0, 1.0), pi / 2)
    >>> [round(begin / pi, 2) for begin, _ in monotonic_parts(circle, 1.0)]
    [0.0, 0.25, 0.75, 1.0, 1.25, 1.75]
    """
    combinations = (NORMAL_LOAD, level(1, friction), level(-1, friction))
    turns = sorted(
        time for combination in combinations for time in segment.turning_points(combination)
    )
    shortest_part = _ROUNDING * max(
        abs(segment.start), abs(segment.end), segment.end - segment.start
    )
    ends_of_parts = [segment.start]
    for time in turns:
        if time - ends_of_parts[-1] > shortest_part and segment.end - time > shortest_part:
            ends_of_parts.append(time)
    return list(zip(ends_of_parts, [*ends_of_parts[1:], segment.end], strict=True))


def march(
    curve: Curve, legs: Sequence[LoadSegment], friction: float, delay: float
) -> tuple[tuple[Span, ...], Curve]:
    """Follow segments of a load path through stick and slip: spans of time, each in full stick or
    with slip in one direction, and the memory curve at the end.

    The memory curve is the tangential force carried up to each load; None stands for no contact.
    `delay` is added to the time of the segments, whole periods of a cycle.

    >>> from scenes.segments import straight_segments
    >>> legs = straight_segments(
    ...     [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 1.0, 0.3), (3.0, 1.0, 0.1)]
    ... )  # rows of t, P, Q
    >>> spans, curve = march(None, legs, 0.5, 0.0)
    >>> [
    ...     (span.direction, round(float(span.slipped(span.end.time)), 12)) for span in spans
    ... ]  # dQ/f, after a reversal dQ/(2 f)
    [(0, 0.0), (1, 0.6), (-1, 0.2)]
    """
    spans: list[Span] = []
    for segment in legs:
        for begin_time, end_time in monotonic_parts(segment, friction):
            for span in _spans_of_part(curve, segment, begin_time, end_time, friction, delay):
                spans.append(span)
                curve = span.curve(span.end.time)
    return tuple(spans), curve


def _spans_of_part(
    curve: Curve, leg: LoadSegment, begin: float, end: float, friction: float, delay: float
) -> Iterator[Span]:
    """Spans of time, in full stick or with slip in one direction, of a part of a load segment.

    On the part neither P, u = Q - f P nor v = Q + f P turns round. Rising u is forward slip,
    falling v reverse slip; neither, with rising P, is loading in stick. The memory curve M(eta) is
    the tangential force of the flat punches up to the load eta. Each piece of it that slip erases
    makes a span of its own.

    Parameters
    ----------
    curve
        the memory curve at the `begin`; None out of contact
    leg
        the load segment
    begin, end
        times of the part
    delay
        how much later than the segment itself the spans are: whole periods of the cycle
    """
    middle = (begin + end) / 2
    normal_rate, tangential_rate = (float(rate) for rate in leg.rates(middle))
    noise = _ROUNDING * (abs(tangential_rate) + friction * abs(normal_rate))
    slips_forward = float(leg.rate_of(level(1, friction), middle)) > noise
    slips_in_reverse = float(leg.rate_of(level(-1, friction), middle)) > noise
    begin_instant = instant(leg, begin)
    end_instant = instant(leg, end)
    if normal_rate > 0 and not (slips_forward or slips_in_reverse):
        yield Span(
            begin_instant,
            end_instant,
            delay,
            0,
            load_in_stick(curve, leg, begin, end_instant),
            friction,
        )
    elif normal_rate < 0 and slips_forward == slips_in_reverse:
        yield from _unload(curve, begin_instant, end_instant, friction, delay)
    elif slips_forward or slips_in_reverse:
        yield from _slip(
            curve, 1 if slips_forward else -1, begin_instant, end_instant, friction, delay
        )
    else:
        yield Span(begin_instant, end_instant, delay, 0, curve, friction)


def _slip(
    curve: Curve,
    direction: int,
    begin_instant: Instant,
    end_instant: Instant,
    friction: float,
    delay: float,
) -> Iterator[Span]:
    """Spans of slip in one direction: the stick edge moves down through the pieces of the memory
    curve, and each piece makes a span of time.

    The memory curve is the tangential force carried up to each load; P_c is the load at the stick
    edge. A piece is passed when s Q - f P, s = `direction`, has grown to its value at the lower end
    of the piece.

    Parameters
    ----------
    curve
        the memory curve at the begin; None out of contact
    direction
        1 of forward, -1 of reverse slip
    begin_instant, end_instant
        ends of the part of a load segment that slips
    delay
        how much later than the segment itself the spans are: whole periods of the cycle
    """
    leg = begin_instant.leg
    slip_level = level(direction, friction)
    total_change = float(leg.change_of(slip_level, end_instant.time, begin_instant.time))
    force_roundoff = _LAST_DIGITS * friction * end_instant.normal
    span_begin = begin_instant
    # What slips already is at the limit, and the stick edge is below it.
    if curve is not None and flat(curve, direction, friction):
        curve = curve.below
    while curve is not None:
        if flat(curve, direction, friction):
            # Only round-off would take the stick edge through it: it stays at its upper end.
            if total_change <= force_roundoff:
                curve = Piece(curve, curve.top, begin_instant, -direction * friction)
                break
            curve = curve.below
            continue
        level_at_begin = float(change_from(curve.anchor, leg, slip_level, begin_instant.time))
        level_at_bottom = float(level_on(curve, direction, friction, curve.bottom))
        change_to_bottom = level_at_bottom - level_at_begin
        # A stick edge that meets the lower end of the piece at the very end of the step, to
        # round-off, has not passed it: what lies below may be at the limit already, and the edge
        # would jump through it.
        level_roundoff = _NEAR * (abs(level_at_bottom) + abs(level_at_begin)) + force_roundoff
        if total_change <= change_to_bottom + level_roundoff:
            break
        passing_time = leg.time_of(
            slip_level, change_to_bottom, begin_instant.time, end_instant.time
        )
        passing_instant = instant(leg, float(passing_time))
        if passing_instant.time > span_begin.time:
            yield Span(span_begin, passing_instant, delay, direction, curve, friction)
            span_begin = passing_instant
        curve = curve.below
    if end_instant.time > span_begin.time:
        yield Span(span_begin, end_instant, delay, direction, curve, friction)


def _unload(
    curve: Curve, begin_instant: Instant, end_instant: Instant, friction: float, delay: float
) -> Iterator[Span]:
    """Spans of time, in full stick or with slip in one direction, of an unloading path with P
    falling and |dQ/dP| <= f.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. The
    contact slips forward where the path runs above the memory curve M(P) in the P-Q plane, in
    reverse below it, and not along it. Each later point of the path lies inside the friction cones
    of the earlier ones, so that the state is that of one step. `delay` is how much later than the
    load segment itself the spans are: whole periods of the cycle.
    """
    for begin_time, end_time, direction in slip_directions(
        curve, begin_instant, end_instant, friction
    ):
        begin_of_part = instant(begin_instant.leg, begin_time)
        end_of_part = instant(begin_instant.leg, end_time)
        if direction:
            for span in _slip(curve, direction, begin_of_part, end_of_part, friction, delay):
                yield span
                curve = span.curve(span.end.time)
        else:
            yield from _retrace(curve, begin_of_part, end_of_part, friction, delay)
            curve = unload_to(curve, end_of_part.normal)


def _retrace(
    curve: Curve, begin_instant: Instant, end_instant: Instant, friction: float, delay: float
) -> Iterator[Span]:
    """Spans of unloading back down the memory curve, Q = M(P), without slip: a span of time for
    each of its pieces.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. `delay`
    is how much later than the load segment itself the spans are: whole periods of the cycle.
    """
    span_begin = begin_instant
    while curve is not None and curve.bottom > end_instant.normal:
        load_change = curve.bottom - begin_instant.normal
        time_at_bottom = begin_instant.leg.time_of(
            NORMAL_LOAD, load_change, begin_instant.time, end_instant.time
        )
        span_end = instant(begin_instant.leg, float(time_at_bottom))
        if span_end.time > span_begin.time:
            yield Span(span_begin, span_end, delay, 0, curve, friction)
            span_begin = span_end
        curve = curve.below
    if end_instant.time > span_begin.time:
        yield Span(span_begin, end_instant, delay, 0, curve, friction)


def slip_directions(
    curve: Curve, begin_instant: Instant, end_instant: Instant, friction: float
) -> list[tuple[float, float, int]]:
    """Begin time, end time and slip direction of the parts of an unloading path: +1 above the
    memory curve M(P), -1 below it, 0 along it.

    `curve` is the memory curve M(eta) at the begin, the tangential force of the flat punches up to
    the load eta. The path goes from `begin_instant` to `end_instant` on one load segment.
    Neighbouring parts of one direction are merged.
    """
    parts: list[tuple[float, float, int]] = []
    part_begin = begin_instant.time
    for piece in pieces(curve):
        change_to_bottom = piece.bottom - begin_instant.normal
        total_change = float(
            begin_instant.leg.change_of(NORMAL_LOAD, end_instant.time, begin_instant.time)
        )
        leaves_piece = total_change < change_to_bottom
        part_end = end_instant.time
        if leaves_piece:
            part_end = float(
                begin_instant.leg.time_of(
                    NORMAL_LOAD, change_to_bottom, begin_instant.time, end_instant.time
                )
            )
        if part_end > part_begin:
            parts += _directions_on(piece, begin_instant.leg, part_begin, part_end, friction)
        part_begin = max(part_begin, part_end)
        if not leaves_piece:
            break
    merged_parts: list[tuple[float, float, int]] = []
    for part in parts:
        if merged_parts and merged_parts[-1][2] == part[2]:
            merged_parts[-1] = (merged_parts[-1][0], part[1], part[2])
        else:
            merged_parts.append(part)
    return merged_parts


def _directions_on(
    piece: Piece, leg: LoadSegment, begin: float, end: float, friction: float
) -> list[tuple[float, float, int]]:
    """Begin time, end time and slip direction of the parts of an unloading path between two times
    at which P is within one `piece` of the memory curve M(P).

    M(eta) is the tangential force of the flat punches up to the load eta. The direction is the sign
    of Q - M(P). It is sampled at some times and at its turning points, and changes at its roots.
    """

    def excess(time: ArrayLike) -> Array:
        if piece.arc is None and piece.bend == 0:
            return change_from(piece.anchor, leg, Combination(-piece.slope, 1.0), time)
        normal_load, tangential_load = leg.loads(time)
        return tangential_load - value_on(
            piece, np.clip(normal_load, piece.bottom, piece.anchor.normal)
        )

    turns = leg.turning_points(Combination(-piece.slope, 1.0)) if piece.arc is None else []
    turns_inside = [time for time in turns if begin < time < end]
    sample_count = 3 if piece.arc is None and piece.bend == 0 else _SAMPLES
    sample_times = np.unique([*np.linspace(begin, end, sample_count), *turns_inside])
    noise = _ROUNDING * (friction * piece.anchor.normal + abs(piece.anchor.tangential))
    excesses = excess(sample_times)
    signs = np.where(np.abs(excesses) <= noise, 0, np.sign(excesses)).astype(int)
    if not np.any(signs):
        return [(begin, end, 0)]
    numbers_with_sign = np.flatnonzero(signs)
    begins_of_parts = [begin]
    directions = [int(signs[numbers_with_sign[0]])]
    time_tolerance = _LAST_DIGITS * (end - begin)
    for number_before, number_after in pairwise(numbers_with_sign):
        if signs[number_before] != signs[number_after]:
            crossing = scipy.optimize.brentq(
                excess,
                sample_times[number_before],
                sample_times[number_after],
                xtol=time_tolerance,
                rtol=_LAST_DIGITS,
            )
            begins_of_parts.append(float(crossing))
            directions.append(int(signs[number_after]))
    return list(zip(begins_of_parts, [*begins_of_parts[1:], end], directions, strict=True))


@dataclass(frozen=True)
class Turn:
    """One revolution: its legs, and what makes their time the history's time."""

    legs: tuple[LoadSegment, ...]
    delay: float = 0.0


@dataclass(frozen=True, eq=False)
class History:
    """The spans of an initial loading and of the cycles after it.

    Attributes
    ----------
    loading
        spans before the first cycle
    cycles
        spans of each solved cycle
    states
        memory curve at the start of each cycle and at the end of the last
    steady_from
        index of the first cycle that ends in the state it started from, None if none did
    period
        duration of a cycle, None for a path that does not repeat
    covered
        for each whole cycle that the answer covers, the index of the solved cycle that it is or
        is a copy of
    loop
        the ellipse, where that is the whole cycle
    """

    loading: tuple[Span, ...]
    cycles: tuple[tuple[Span, ...], ...]
    states: tuple[Curve, ...]
    steady_from: int | None
    period: float | None = None
    covered: tuple[int, ...] = (0,)
    loop: LoadSegment | None = None

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """All spans in the order of time."""
        return (*self.loading, *(span for cycle in self.cycles for span in cycle))

    @property
    def largest(self) -> float:
        """The largest P at the ends of spans."""
        return max(max(span.begin.normal, span.end.normal) for span in self.spans)

    @property
    def repeats(self) -> bool:
        """Whether cycles after the steady one are copies."""
        return self.period is not None

    @property
    def long(self) -> bool:
        """Whether the path is answered at its rows: it has none."""
        return False

    def default_times(self, last_cycle_only: bool, _thinned: bool = False) -> tuple[Array, int]:
        """Instants of the answer where none are asked for: evenly spread over each span of one
        state of stick or slip, both ends of each, about 400 a cycle.

        With them 0, the number of rows left out: a curved path has no rows.
        """
        spans_of_cycles = list(self.cycles[-1:])
        if not last_cycle_only:
            spans_of_cycles = list(self.cycles)
            if self.loading:
                spans_of_cycles.append(self.loading)
        times = []
        for spans in spans_of_cycles:
            ends_of_spans = np.array([spans[0].begin.time, *(span.end.time for span in spans)])
            times.append(evenly(ends_of_spans, initial=spans is self.loading) + spans[0].delay)
        return np.unique(np.concatenate(times)), 0

    def snapshot(self, time: Array) -> Snapshot:
        """The memory of friction at instants (n,) of the followed path: loads, slip, and the memory
        curve at each.

        The memory curve M(eta) is the tangential force of the flat punches up to the load eta. An
        instant between two spans of stick or slip belongs to the one that ends there. Instants
        beyond the followed cycles are brought back by whole periods.

        Raises
        ------
        InputError
            For a time outside the path.
        """
        spans = self.spans
        span_begins = np.array([span.begin.time for span in spans])
        span_ends = np.array([span.end.time for span in spans])
        span_delays = np.array([span.delay for span in spans])
        path_ends = span_ends + span_delays
        path_time, slack = within(
            time, float(span_begins[0] + span_delays[0]), float(path_ends[-1]), self.period
        )
        # Minus the slack: a turning point that is right to round-off still belongs to the span
        # that it ends.
        number_of_span = np.minimum(
            np.searchsorted(path_ends, path_time - slack, side="left"), len(spans) - 1
        )
        times_in_segments = np.clip(
            path_time - span_delays[number_of_span],
            span_begins[number_of_span],
            span_ends[number_of_span],
        )
        order_by_span = np.argsort(number_of_span, kind="stable")
        numbers_with_times, first_of_span = np.unique(
            number_of_span[order_by_span], return_index=True
        )
        times_of_spans = np.split(times_in_segments[order_by_span], first_of_span[1:])
        snapshot = snapshot_of(
            (spans[k], times) for k, times in zip(numbers_with_times, times_of_spans, strict=True)
        )
        order_in_time = np.argsort(order_by_span)
        columns = ("time", "load", "force", "slipped", "direction", "piece_number")
        return replace(
            snapshot, **{name: getattr(snapshot, name)[order_in_time] for name in columns}
        )


def follow(loading: Sequence[LoadSegment], turns: Iterable[Turn], friction: float) -> History:
    """Friction history of an initial loading and of the `turns`, whole cycles, up to the first
    cycle that ends as it began; f is `friction`.

    A cycle is steady where its memory curves at begin and end agree. A memory curve M(eta) is the
    tangential force of the flat punches up to the load eta.

    Raises
    ------
    InadmissibleLoadError
        Gross sliding or separation, with the instant and the loads.
    """
    spans, curve = march(None, loading, friction, 0.0)
    curves_between_cycles = [curve]
    cycles = []
    steady_from = None
    for cycle_number, turn in enumerate(turns):
        cycle, curve = march(curve, turn.legs, friction, turn.delay)
        cycles.append(cycle)
        curves_between_cycles.append(curve)
        if same(curves_between_cycles[-2], curve, friction, repeats_within(slipped_share(cycle))):
            steady_from = cycle_number
            break
    return History(spans, tuple(cycles), tuple(curves_between_cycles), steady_from)


def is_plain_ellipse(segment: LoadSegment) -> bool:
    """Whether a segment is the cycle of an `EllipseLoad`, from the paper's point A on; one of a
    `HarmonicLoad` starts at time 0.
    """
    return segment.ellipse is not None and segment.ellipse.origin == 0 and segment.start != 0


def history_of(path: LoadPath, friction: float, cycles: int, time: Array | None = None) -> History:
    """States of stick and slip along a load path: as many cycles as the instants `time` need;
    without them, until the memory of friction repeats, `cycles` at most.

    A history that is stored is taken instead of followed again, also a longer one that became
    steady within as many cycles.
    """
    most_cycles = 0
    cycles_covered = 0
    if path.period is not None:
        most_cycles, cycles_covered = turns_of(path.cycle_start, path.period, cycles, time)
    kept_histories = _kept_histories.get()
    if kept_histories is None:
        kept_histories = {}
    histories_of_path = kept_histories.setdefault((path, friction), {})
    history = histories_of_path.get(most_cycles)
    for cycles_followed, longer_history in histories_of_path.items():
        # What is steady within these cycles has no others.
        if len(longer_history.cycles) <= most_cycles < cycles_followed:
            history = longer_history
    if history is None:
        history = histories_of_path[most_cycles] = _followed_path(path, friction, most_cycles)
    if path.period is None:
        return history
    cycles_solved = len(history.cycles)
    covered_cycles = tuple(
        min(number, cycles_solved - 1) for number in range(cycles_covered or cycles_solved)
    )
    return replace(history, covered=covered_cycles)


@contextmanager
def histories_kept() -> Iterator[None]:
    """Meanwhile a path that is asked for again is not followed again."""
    token = _kept_histories.set({})
    try:
        yield
    finally:
        _kept_histories.reset(token)


def _followed_path(path: LoadPath, friction: float, turn_count: int) -> History:
    """Friction history of a load path, its initial loading and `turn_count` cycles at most;
    InputError for bulk stress or tilt.

    A path without a period counts as one cycle. f is `friction`.
    """
    if path.has_bulk_or_tilt:
        raise InputError(
            "load: half-plane theory with one memory curve takes neither bulk stress nor tilt"
        )
    check([*path.initial_loading, *path.cycle], friction)
    if path.period is None:
        return follow((), [Turn(path.initial_loading)], friction)
    turns = (Turn(path.cycle, k * path.period) for k in range(turn_count))
    history = follow(path.initial_loading, turns, friction)
    ellipse_of_cycle = (
        path.cycle[0] if len(path.cycle) == 1 and is_plain_ellipse(path.cycle[0]) else None
    )
    return replace(history, period=path.period, loop=ellipse_of_cycle)


def turns_of(start: float, period: float, cycles: int, time: Array | None) -> tuple[int, int]:
    """How many cycles must be followed at most for the instants `time`, and how many whole cycles
    these cover, 0 where they end within the first.

    Without instants they are `cycles` and 0. The first cycle begins at time `start`.
    """
    if time is None:
        return cycles, 0
    cycles_to_last_instant = (float(np.max(time)) - start) / period
    covered_count = max(math.floor(cycles_to_last_instant + SLACK), 0)
    begun_count = math.ceil(cycles_to_last_instant - SLACK)
    if covered_count:
        return max(begun_count, 0), covered_count
    return max(cycles, begun_count), 0


def within(time: Array, start: float, end: float, period: float | None) -> tuple[Array, float]:
    """Instants (n,) moved by whole periods into the part of a load path that was followed, and by
    how much they may lie outside of it.

    The part runs from `start` to `end`; later instants of a path without a `period` are refused.

    Raises
    ------
    InputError
        For a time outside the path.
    """
    slack = SLACK * (end - start)
    path_time = time
    if period is not None:
        path_time = time - period * np.maximum(np.ceil((time - end - slack) / period), 0.0)
    if np.any(path_time < start - slack) or np.any(path_time > end + slack):
        raise InputError(f"time: outside the load path, which runs from {start:.6g} to {end:.6g}")
    return path_time, slack


def evenly(marks: Array, *, initial: bool) -> Array:
    """Instants between marks of time, ascending, and at them: about 400 of a cycle, 100 of an
    `initial` loading.
    """
    instants = _INSTANTS_OF_LOADING if initial else _INSTANTS
    steps = np.maximum(np.ceil(instants * np.diff(marks) / (marks[-1] - marks[0])), 2)
    times = [
        np.linspace(begin, end, int(count) + 1)
        for begin, end, count in zip(marks[:-1], marks[1:], steps, strict=True)
    ]
    return np.concatenate(times)


def slipped_share(spans: Sequence[Span]) -> float:
    """Largest (P - P_c)/P of some spans, seen at their ends and half-way; 0 where nothing slips."""
    largest_slip = max((span.deepest for span in spans), default=0.0)
    largest_load = max((max(span.begin.normal, span.end.normal) for span in spans), default=0.0)
    return largest_slip / largest_load if largest_load > 0 else 0.0


def snapshot_of(parts: Iterable[tuple[Span, Array]]) -> Snapshot:
    """Friction states at instants of some spans of a load path, one span after the other; each
    comes with times (k,) of its load segment.

    A span is a time in full stick or with slip in one direction. A state is P, Q, the load P - P_c
    beyond the stick edge, the direction of slip, and the piece of the memory curve below the slip.
    The memory curve M(eta) is the tangential force of the flat punches up to the load eta.
    """
    times = []
    normal_loads = []
    tangential_loads = []
    slipped_loads = []
    directions = []
    counts_of_times = []
    pieces_below_slip: list[Curve] = []
    friction = 0.0
    for span, times_in_segment in parts:
        normal_load, tangential_load = span.leg.loads(times_in_segment)
        normal_load = np.maximum(
            normal_load, 0.0
        )  # a path that unloads fully may end below 0 by rounding
        times.append(times_in_segment)
        normal_loads.append(normal_load)
        tangential_loads.append(tangential_load)
        slipped_loads.append(span.slipped_at(times_in_segment, normal_load))
        directions.append(span.direction)
        counts_of_times.append(len(times_in_segment))
        pieces_below_slip.append(span.sticking_piece)
        friction = span.friction
    return Snapshot(
        time=np.concatenate(times),
        load=np.concatenate(normal_loads),
        force=np.concatenate(tangential_loads),
        slipped=np.concatenate(slipped_loads),
        direction=np.repeat(np.array(directions), counts_of_times),
        piece_number=np.repeat(np.arange(len(pieces_below_slip)), counts_of_times),
        uppermost_pieces=tuple(pieces_below_slip),
        friction=friction,
    )


def corner_times(contact: Contact, span: Span) -> Array:
    """Times within a span at which an edge of contact or of stick passes a corner of the profile,
    (n,) ascending and apart: integrands over time have a kink there.

    A span is a time in full stick or with slip in one direction. At a corner P, or the load P_c at
    the stick edge, equals one of the contact's `break_loads`.
    """
    loads = contact.break_loads
    leg = span.leg
    begin_instant = span.begin
    end_instant = span.end
    if not len(loads):
        return loads
    least_load = min(begin_instant.normal, end_instant.normal)
    largest_load = max(begin_instant.normal, end_instant.normal)
    passed_loads = loads[(loads > least_load) & (loads < largest_load)]
    times = [
        leg.time_of(
            NORMAL_LOAD, passed_loads - begin_instant.normal, begin_instant.time, end_instant.time
        )
    ]
    if span.direction and span.sticking_piece is not None:
        loads_on_piece = loads[
            (loads > span.sticking_piece.bottom) & (loads < span.sticking_piece.top)
        ]
        slip_level = level(span.direction, span.friction)
        level_at_begin = float(
            change_from(span.sticking_piece.anchor, leg, slip_level, begin_instant.time)
        )
        levels = level_on(span.sticking_piece, span.direction, span.friction, loads_on_piece)
        times.append(
            leg.time_of(slip_level, levels - level_at_begin, begin_instant.time, end_instant.time)
        )
    shortest_time = 1e-12 * max(
        abs(begin_instant.time), abs(end_instant.time), end_instant.time - begin_instant.time
    )
    sorted_times = np.sort(np.concatenate(times))
    sorted_times = sorted_times[
        (sorted_times - begin_instant.time > shortest_time)
        & (end_instant.time - sorted_times > shortest_time)
    ]
    return sorted_times[np.diff(sorted_times, prepend=-np.inf) > shortest_time]
