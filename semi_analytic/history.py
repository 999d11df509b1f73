"""Curved load paths: which part of a load segment sticks, which slips, which piece of the memory
curve is being erased, and when (Masing rule).

A history is a sequence of time spans, in each of which the memory curve keeps its structure. An
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
from typing import Literal

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
    combination_change,
    force_on_piece,
    instant,
    is_at_coulomb_limit,
    is_same_memory,
    load_in_stick,
    load_of_slip_zone,
    pieces,
    repeat_tolerance,
    slip_combination,
    slip_combination_on_piece,
    slip_to,
    unload_to,
)
from semi_analytic.profiles import Contact

# Share of the largest load, or of the rates of P and Q, below which a difference is rounding.
_ROUND_OFF_SHARE = 1e-14
# Share of a range of time, or of a load combination, within which two instants are one.
_SAME_INSTANT_SHARE = 1e-14
# Share of f P by which a stick edge may miss the end of the piece that it meets, and of a time to
# which a crossing is found.
_STICK_EDGE_ROUNDOFF_SHARE = 2e-15
# Instants at which Q - M(P) is looked at along a curved piece, whose crossings have no formula.
_SAMPLES_OF_CURVED_PIECE = 33
# Instants of a cycle and of the initial loading where none are asked for.
_INSTANTS_OF_CYCLE = 400
_INSTANTS_OF_LOADING = 100
# Histories that are kept while `histories_kept` holds, by path and friction, then by the most
# cycles that were followed.
_HistoriesByPath = dict[tuple[LoadPath, float], dict[int, "History"]]
_kept_histories: ContextVar[_HistoriesByPath | None] = ContextVar("histories", default=None)
# Share of a cycle, or of the whole path, within which an instant of the user counts as one of the
# path.
INSTANT_SLACK_SHARE = 1e-9


@dataclass(frozen=True, eq=False)
class Span:
    """A span of time, in full stick or with slip in one direction, in which the memory curve keeps
    its structure.

    Attributes
    ----------
    begin, end
        its ends on the load path, in the time of the load segment
    delay
        how much later the span is than the segment's own time: whole periods of the cycle
    direction
        +1 forward slip, -1 reverse slip, 0 no slip
    sticking_piece
        the uppermost piece of the memory curve that still sticks, below the line of slip; None if
        the whole contact slips, P_c = 0
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
    def segment(self) -> LoadSegment:
        """The load segment that the span is on."""
        return self.begin.segment

    def slip_zone_load(self, time: ArrayLike) -> Array:
        """P - P_c >= 0 [force per thickness] at times of the segment, P_c the load at the stick
        edge; 0 where nothing slips.
        """
        t = np.asarray(time, dtype=float)
        return self.slip_zone_load_at(t, self.segment.loads(t)[0])

    def slip_zone_load_at(self, t: Array, load: Array) -> Array:
        """P - P_c >= 0 at times t of the segment at which P is `load`, P_c the load at the stick
        edge; 0 where nothing slips (`direction` 0), P where all does (no piece).

        The memory curve is the tangential force carried up to each load. The stick edge stays on
        one piece of it, `sticking_piece`, between the loads `bottom_load` and `top_load`.
        """
        if self.direction == 0:
            return np.zeros(t.shape)
        if self.sticking_piece is None:
            return load
        # P - P_c by the formula for this piece
        slip_zone_load = load_of_slip_zone(
            self.sticking_piece, self.direction, self.friction, self.segment, t
        )
        least_slip_zone_load = np.maximum(load - self.sticking_piece.top_load, 0.0)
        largest_slip_zone_load = load - self.sticking_piece.bottom_load
        # of a single number two calls take a quarter of the time of `clip`
        return np.minimum(np.maximum(slip_zone_load, least_slip_zone_load), largest_slip_zone_load)

    @cached_property
    def largest_slip_zone_load(self) -> float:
        """Largest P - P_c [force per thickness] at the ends of the span and half-way; 0 where
        nothing slips.
        """
        if not self.direction:
            return 0.0
        return float(np.max(self.slip_zone_load(np.linspace(self.begin.time, self.end.time, 3))))

    def curve(self, time: float) -> Curve:
        """The memory curve M(eta), the tangential force of the flat punches up to the load eta, at
        a time of the segment; None out of contact.

        In a span without slip it is what lies below P. In a span with slip it is at the Coulomb
        limit, dM/d eta = +-f, from the stick edge P_c = P - `slip_zone_load` up. `sticking_piece`
        is the uppermost piece that still sticks.
        """
        # P and Q at the time
        instant_at_time = instant(self.segment, time)
        if self.direction == 0:
            return unload_to(self.sticking_piece, instant_at_time.normal_load)
        return slip_to(
            self.sticking_piece,
            self.direction,
            self.friction,
            instant_at_time,
            float(self.slip_zone_load(time)),
        )


def require_admissible(segments: Sequence[LoadSegment], friction: float) -> None:
    """Refuse a load path on which the contact slides as a whole, |Q| > f P, or separates, P < 0:
    InadmissibleLoadError at the first such instant of the `segments`.

    |Q| = f P is admitted, to 1e-14 of f times the largest load: in any unit, for any
    f = `friction`.

    >>> from scenes import StraightSegment
    >>> require_admissible(
    ...     [StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.5))], 0.5
    ... )  # |Q| = f P is reached at the end, not exceeded
    >>> require_admissible([StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.6))], 0.3)
    Traceback (most recent call last):
    scenes.errors.InadmissibleLoadError: load: gross sliding from time 0.5 on, at time 1 with P = 1,
    Q = 0.6, f = 0.3: ...
    >>> require_admissible([StraightSegment(0.0, 1.0, (1.0, 0.0), (-1.0, 0.0))], 0.3)
    Traceback (most recent call last):
    scenes.errors.InadmissibleLoadError: load: separation from time 0.5 on, at time 1 with P = -1, Q
    = 0: ...
    """
    largest_load = max(
        abs(float(segment.loads(time)[0]))
        for segment in segments
        for time in (segment.start, segment.end)
    )
    for segment in segments:
        # between turning points of P, Q - f P and Q + f P
        for begin_time, end_time in monotonic_parts(segment, friction):
            _check_part(segment, begin_time, end_time, friction, _ROUND_OFF_SHARE * largest_load)


def _check_part(
    segment: LoadSegment, begin_time: float, end_time: float, friction: float, load_slack: float
) -> None:
    """Raise InadmissibleLoadError where |Q| > f P or P < 0 on a part of a load segment, with the
    first such instant; None for an admissible part.

    P, Q - f P and Q + f P are monotonic from `begin_time` to `end_time` of the part. So its end is
    beyond a limit if anything is. P may be beyond its limit by `load_slack` [force per
    thickness], Q by f times that, f = `friction`. The error also names the end of the part.
    """
    end_instant = instant(segment, end_time)
    faults = []
    for load_combination, excess, reason in _excesses_over_limits(end_instant, friction):
        load_tolerance = load_slack if load_combination is NORMAL_LOAD else load_slack * friction
        if excess > load_tolerance:
            # -P grows to its limit 0, and so do Q - f P and -Q - f P.
            sign_of_growth = -1.0 if load_combination is NORMAL_LOAD else 1.0
            # change of the combination since the start of the part
            growth_in_part = sign_of_growth * float(
                segment.change_of(load_combination, end_time, begin_time)
            )
            growth_to_limit = growth_in_part - excess
            # the inverse of `change_of`: when it has changed by that much
            fault_time = float(
                segment.time_of(
                    load_combination, sign_of_growth * growth_to_limit, begin_time, end_time
                )
            )
            faults.append((fault_time, reason))
    if not faults:
        return
    # Where P reaches 0 both limits of friction are met at the same instant: that is separation.
    # `faults` are times and reasons, separation first; _SAME_INSTANT_SHARE is 1e-14.
    latest_time_of_first_fault = min(
        fault_time for fault_time, _ in faults
    ) + _SAME_INSTANT_SHARE * (end_time - begin_time)
    time_of_first_fault, reason = next(
        (fault_time, reason)
        for fault_time, reason in faults
        if fault_time <= latest_time_of_first_fault
    )
    fault_instant = instant(segment, time_of_first_fault)
    raise InadmissibleLoadError(
        reason,
        LoadedInstant(
            time_of_first_fault, fault_instant.normal_load, fault_instant.tangential_load
        ),
        # The excess grows up to the end of the part, where it is largest.
        LoadedInstant(end_instant.time, end_instant.normal_load, end_instant.tangential_load),
        friction=friction,
    )


def _excesses_over_limits(
    checked_instant: Instant, friction: float
) -> list[tuple[Combination, float, Literal["separation", "gross sliding"]]]:
    """By how much the loads P and Q of an instant exceed the limits of contact, negative within
    them: load combination, excess [force per thickness] and what happens beyond the limit.

    First P: the excess is -P, separation. Then Q - f P and -Q - f P, gross sliding forward and in
    reverse, f = `friction`.
    """
    excesses: list[tuple[Combination, float, Literal["separation", "gross sliding"]]] = [
        (NORMAL_LOAD, -checked_instant.normal_load, "separation")
    ]
    for direction in (1, -1):
        excess_over_friction_limit = (
            direction * checked_instant.tangential_load - friction * checked_instant.normal_load
        )
        load_combination = slip_combination(direction, friction)
        excesses.append((load_combination, excess_over_friction_limit, "gross sliding"))
    return excesses


def monotonic_parts(segment: LoadSegment, friction: float) -> list[tuple[float, float]]:
    """Parts of a load segment between turning points of P, of Q - f P and of Q + f P, f =
    `friction`: start and end time of each.

    The contact may slip forward where Q - f P rises, and in reverse where Q + f P falls. Turning
    points are times at which a combination of the loads stops growing or falling.

    >>> from math import pi
    >>> from scenes import ellipse_segment
    >>> circle = ellipse_segment(0.0, 2 * pi, (3.0, 0.0), (1.0, 1.0), pi / 2)
    >>> [round(begin / pi, 2) for begin, _ in monotonic_parts(circle, 1.0)]
    [0.0, 0.25, 0.75, 1.0, 1.25, 1.75]
    """
    load_combinations = (NORMAL_LOAD, slip_combination(1, friction), slip_combination(-1, friction))
    turning_times = sorted(
        time
        for load_combination in load_combinations
        for time in segment.turning_points(load_combination)
    )
    # _ROUND_OFF_SHARE: 1e-14
    shortest_duration = _ROUND_OFF_SHARE * max(
        abs(segment.start), abs(segment.end), segment.end - segment.start
    )
    begin_times = [segment.start]
    for time in turning_times:
        if time - begin_times[-1] > shortest_duration and segment.end - time > shortest_duration:
            begin_times.append(time)
    return list(zip(begin_times, [*begin_times[1:], segment.end], strict=True))


def spans_along(
    curve: Curve, segments: Sequence[LoadSegment], friction: float, delay: float
) -> tuple[tuple[Span, ...], Curve]:
    """Time spans of full stick, or of slip in one direction, along load segments, and the memory
    curve at their end; `curve` is that at their start.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta; None
    where there is no contact. Slip erases its upper end, loading in stick extends it. A segment is
    first cut into parts on which P, Q - f P and Q + f P are monotonic. The spans are `delay` later
    than the time of the segments: whole periods of a cycle. f is the friction.

    >>> from scenes.segments import straight_segments
    >>> segments = straight_segments(
    ...     [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 1.0, 0.3), (3.0, 1.0, 0.1)]
    ... )  # rows of t, P, Q
    >>> spans, curve = spans_along(None, segments, 0.5, 0.0)
    >>> [
    ...     (span.direction, round(float(span.slip_zone_load(span.end.time)), 12)) for span in spans
    ... ]  # P - P_c is dQ/f, after a reversal dQ/(2 f)
    [(0, 0.0), (1, 0.6), (-1, 0.2)]
    """
    spans: list[Span] = []
    for segment in segments:
        for begin_time, end_time in monotonic_parts(segment, friction):
            for span in _spans_of_part(curve, segment, begin_time, end_time, friction, delay):
                spans.append(span)
                curve = span.curve(span.end.time)
    return tuple(spans), curve


def _spans_of_part(
    memory_curve: Curve,
    segment: LoadSegment,
    begin_time: float,
    end_time: float,
    friction: float,
    delay: float,
) -> Iterator[Span]:
    """Time spans of full stick, or of slip in one direction, on a part of a load segment on which
    P, Q - f P and Q + f P are monotonic.

    Rising Q - f P is forward slip, falling Q + f P reverse slip. Neither, with rising P, is loading
    in stick. Both, with falling P, is unloading: the memory curve decides on slip. Loads that rest
    make one span of stick. Each smooth piece of the memory curve that slip erases makes a span of
    its own. An instant holds its segment, time, P and Q.

    Parameters
    ----------
    memory_curve
        M(eta) at the start, the tangential force of the flat punches up to the load eta; None out
        of contact
    segment
        the load segment, with rates dP/dt, dQ/dt
    begin_time, end_time
        ends of the part
    friction
        f
    delay
        how much later than the segment itself the spans are: whole periods of the cycle
    """
    middle_time = (begin_time + end_time) / 2
    normal_rate, tangential_rate = (float(rate) for rate in segment.rates(middle_time))
    # _ROUND_OFF_SHARE: 1e-14
    rate_roundoff = _ROUND_OFF_SHARE * (abs(tangential_rate) + friction * abs(normal_rate))
    slips_forward = (
        float(segment.rate_of(slip_combination(1, friction), middle_time)) > rate_roundoff
    )
    slips_in_reverse = (
        float(segment.rate_of(slip_combination(-1, friction), middle_time)) > rate_roundoff
    )
    # four cases: loading in stick, unloading, slip, rest
    begin_instant = instant(segment, begin_time)
    end_instant = instant(segment, end_time)
    if normal_rate > 0 and not (slips_forward or slips_in_reverse):
        # 0: no slip; the curve grows by the load path itself
        yield Span(
            begin_instant,
            end_instant,
            delay,
            0,
            load_in_stick(memory_curve, segment, begin_time, end_instant),
            friction,
        )
    elif normal_rate < 0 and slips_forward == slips_in_reverse:
        yield from _unloading_spans(memory_curve, begin_instant, end_instant, friction, delay)
    elif slips_forward or slips_in_reverse:
        yield from _slip_spans(
            memory_curve, 1 if slips_forward else -1, begin_instant, end_instant, friction, delay
        )
    else:
        yield Span(begin_instant, end_instant, delay, 0, memory_curve, friction)


def _slip_spans(
    memory_curve: Curve,
    direction: int,
    begin_instant: Instant,
    end_instant: Instant,
    friction: float,
    delay: float,
) -> Iterator[Span]:
    """Time spans of slip in one direction, on a part of a load segment: one span for each smooth
    piece of the memory curve through which the stick edge moves.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. In slip
    of direction s it is erased from above, down to the load P_c at the stick edge. There s M(P_c) -
    f P_c is the level s Q - f P of the loads, which grows. The edge has passed a piece when the
    level has grown to that of the piece's lower end.

    Parameters
    ----------
    memory_curve
        the curve at the start, by its uppermost piece; None out of contact. A piece goes from
        `bottom_load` to `top_load` in eta; `curve_below` is the next lower piece. `anchor` is the
        instant of the path from which it is measured
    direction
        s, 1 of forward, -1 of reverse slip
    begin_instant, end_instant
        ends of the part of a load segment: time, P and Q
    friction
        f
    delay
        how much later than the segment itself the spans are: whole periods of the cycle
    """
    segment = begin_instant.segment
    s_q_minus_f_p = slip_combination(direction, friction)
    level_growth_in_part = float(
        segment.change_of(s_q_minus_f_p, end_instant.time, begin_instant.time)
    )
    # _STICK_EDGE_ROUNDOFF_SHARE: 2e-15 of f P
    level_roundoff_by_loads = _STICK_EDGE_ROUNDOFF_SHARE * friction * end_instant.normal_load
    span_begin_instant = begin_instant
    # the piece in which the stick edge is
    sticking_piece = memory_curve
    # A piece at the Coulomb limit slips already: the stick edge begins below it.
    if sticking_piece is not None and is_at_coulomb_limit(sticking_piece, direction, friction):
        sticking_piece = sticking_piece.curve_below
    while sticking_piece is not None:
        if is_at_coulomb_limit(sticking_piece, direction, friction):
            # A piece at the limit is passed at once. If only round-off would take the stick edge
            # through it, the edge stays at its upper end.
            if level_growth_in_part <= level_roundoff_by_loads:
                # a piece of no length, with slope dM/d eta = -s f
                sticking_piece = Piece(
                    sticking_piece, sticking_piece.top_load, begin_instant, -direction * friction
                )
                break
            sticking_piece = sticking_piece.curve_below
            continue
        # Both relative to the level at the instant from which the piece is measured.
        level_at_begin = float(
            combination_change(sticking_piece.anchor, segment, s_q_minus_f_p, begin_instant.time)
        )
        level_at_bottom = float(
            slip_combination_on_piece(
                sticking_piece, direction, friction, sticking_piece.bottom_load
            )
        )
        level_growth_to_bottom = level_at_bottom - level_at_begin
        # A stick edge that meets the lower end of the piece at the very end of the part, to
        # round-off, has not passed it: what lies below may be at the limit already, and the edge
        # would jump through it.
        # _SAME_INSTANT_SHARE: 1e-14
        level_roundoff = (
            _SAME_INSTANT_SHARE * (abs(level_at_bottom) + abs(level_at_begin))
            + level_roundoff_by_loads
        )
        if level_growth_in_part <= level_growth_to_bottom + level_roundoff:
            break
        # when the level has grown to that of the lower end
        passing_time = segment.time_of(
            s_q_minus_f_p, level_growth_to_bottom, begin_instant.time, end_instant.time
        )
        passing_instant = instant(segment, float(passing_time))
        if passing_instant.time > span_begin_instant.time:
            yield Span(
                span_begin_instant, passing_instant, delay, direction, sticking_piece, friction
            )
            span_begin_instant = passing_instant
        sticking_piece = sticking_piece.curve_below
    if end_instant.time > span_begin_instant.time:
        yield Span(span_begin_instant, end_instant, delay, direction, sticking_piece, friction)


def _unloading_spans(
    memory_curve: Curve, begin_instant: Instant, end_instant: Instant, friction: float, delay: float
) -> Iterator[Span]:
    """Time spans of full stick, or of slip in one direction, on a part of a load segment on which P
    falls and |dQ/dP| <= f.

    `memory_curve` is M(eta) at the start, the tangential force of the flat punches up to the load
    eta. Without slip the contact would carry M(P) alone. So it slips forward where the path runs
    above M(P) in the P-Q plane, in reverse below it, and not along it. Each later point of the path
    lies inside the Coulomb limits |dQ| <= f |dP| of the earlier ones. So a cut of the path does not
    change the memory curve. The spans are `delay` later than the load segment itself: whole periods
    of the cycle. `begin_instant` and `end_instant` hold time, P and Q.
    """
    # start and end time and direction of slip: 1 above the curve, -1 below, 0 along it
    for begin_time, end_time, direction in slip_directions(
        memory_curve, begin_instant, end_instant, friction
    ):
        part_begin_instant = instant(begin_instant.segment, begin_time)
        part_end_instant = instant(begin_instant.segment, end_time)
        if direction:
            for span in _slip_spans(
                memory_curve, direction, part_begin_instant, part_end_instant, friction, delay
            ):
                yield span
                memory_curve = span.curve(span.end.time)
        else:
            yield from _retracing_spans(
                memory_curve, part_begin_instant, part_end_instant, friction, delay
            )
            # of the memory curve there remains what lies below P
            memory_curve = unload_to(memory_curve, part_end_instant.normal_load)


def _retracing_spans(
    memory_curve: Curve,
    begin_instant: Instant,
    end_instant: Instant,
    friction: float,
    delay: float,
) -> Iterator[Span]:
    """Time spans of unloading without slip, Q = M(P): one span for each smooth piece of the memory
    curve that P goes down.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta.
    `memory_curve` is that at the start, by its uppermost piece; None out of contact. A piece ends
    at `bottom_load`; `curve_below` is the next lower one. `begin_instant` and `end_instant` hold
    time, P and Q. The spans are `delay` later than the load segment itself: whole periods of the
    cycle.
    """
    span_begin_instant = begin_instant
    sticking_piece = memory_curve
    while sticking_piece is not None and sticking_piece.bottom_load > end_instant.normal_load:
        load_change = sticking_piece.bottom_load - begin_instant.normal_load
        # at which P is at the lower end of the piece
        time_at_bottom = begin_instant.segment.time_of(
            NORMAL_LOAD, load_change, begin_instant.time, end_instant.time
        )
        span_end_instant = instant(begin_instant.segment, float(time_at_bottom))
        if span_end_instant.time > span_begin_instant.time:
            yield Span(span_begin_instant, span_end_instant, delay, 0, sticking_piece, friction)
            span_begin_instant = span_end_instant
        sticking_piece = sticking_piece.curve_below
    if end_instant.time > span_begin_instant.time:
        yield Span(span_begin_instant, end_instant, delay, 0, sticking_piece, friction)


def slip_directions(
    curve: Curve, begin_instant: Instant, end_instant: Instant, friction: float
) -> list[tuple[float, float, int]]:
    """Parts of an unloading path by direction of slip, +1 above the memory curve M(P), -1 below it,
    0 along it: start time, end time and direction of each.

    `curve` is the memory curve M(eta) at the start, the tangential force of the flat punches up to
    the load eta. The path goes from `begin_instant` to `end_instant` on one load segment, P
    falling. It is cut where P leaves a smooth piece of the curve; neighbouring parts of one
    direction are merged.

    As P falls, the flat punches above P let go. The others carry Q = M(P) without slip; a larger Q
    takes forward slip, a smaller one reverse slip.
    """
    segment = begin_instant.segment
    end_time = end_instant.time
    # fall of P from start to end of the path, negative
    load_change_in_path = float(segment.change_of(NORMAL_LOAD, end_time, begin_instant.time))
    parts_by_direction: list[tuple[float, float, int]] = []
    time_at_piece_top = begin_instant.time
    # from the uppermost piece down
    for memory_piece in pieces(curve):
        load_change_to_bottom = memory_piece.bottom_load - begin_instant.normal_load
        load_leaves_piece = load_change_in_path < load_change_to_bottom
        time_at_piece_bottom = end_time
        # when P is at the lower end of the piece, else the end of the path
        if load_leaves_piece:
            time_at_piece_bottom = float(
                segment.time_of(NORMAL_LOAD, load_change_to_bottom, begin_instant.time, end_time)
            )
        if time_at_piece_bottom > time_at_piece_top:
            parts_by_direction += _parts_on_piece(
                memory_piece, segment, time_at_piece_top, time_at_piece_bottom, friction
            )
        time_at_piece_top = max(time_at_piece_top, time_at_piece_bottom)
        if not load_leaves_piece:
            break

    # merge neighbouring parts of one direction
    merged_parts: list[tuple[float, float, int]] = []
    for begin_time_of_part, end_time_of_part, direction in parts_by_direction:
        merged_begin_time = begin_time_of_part
        if merged_parts:
            begin_time_of_last_part, _, direction_of_last_part = merged_parts[-1]
            if direction_of_last_part == direction:
                merged_begin_time = begin_time_of_last_part
                merged_parts.pop()
        merged_parts.append((merged_begin_time, end_time_of_part, direction))
    return merged_parts


def _parts_on_piece(
    memory_piece: Piece, segment: LoadSegment, begin_time: float, end_time: float, friction: float
) -> list[tuple[float, float, int]]:
    """Parts by direction of slip of an unloading path between two times, while P is within one
    piece of the memory curve M(P): start time, end time and direction of each.

    M(eta) is the tangential force of the flat punches up to the load eta. The direction is the sign
    of Q - M(P): 1, -1, or 0 where the path retraces the curve without slip. It is sampled at some
    times, and the zero of Q - M(P) between two samples of opposite sign is found. Q - M(P) counts
    as 0 up to 1e-14 of f P + |Q| at the upper end of the piece, its `anchor`. f is the friction.
    """
    force_above_piece = _ForceAbovePiece(memory_piece, segment)
    sample_times = force_above_piece.sample_times(begin_time, end_time)
    forces_at_samples = force_above_piece(sample_times)
    # _ROUND_OFF_SHARE: 1e-14
    force_roundoff = _ROUND_OFF_SHARE * (
        friction * memory_piece.anchor.normal_load + abs(memory_piece.anchor.tangential_load)
    )
    direction_at_samples = np.where(
        np.abs(forces_at_samples) <= force_roundoff, 0, np.sign(forces_at_samples)
    ).astype(int)
    if not np.any(direction_at_samples):
        return [(begin_time, end_time, 0)]

    # the direction changes where Q - M(P) = 0 between two samples
    sample_numbers_off_curve = np.flatnonzero(direction_at_samples)
    begin_times = [begin_time]
    directions = [int(direction_at_samples[sample_numbers_off_curve[0]])]
    # _STICK_EDGE_ROUNDOFF_SHARE: 2e-15
    time_tolerance = _STICK_EDGE_ROUNDOFF_SHARE * (end_time - begin_time)
    for number_before, number_after in pairwise(sample_numbers_off_curve):
        if direction_at_samples[number_before] != direction_at_samples[number_after]:
            crossing_time = scipy.optimize.brentq(
                force_above_piece,
                sample_times[number_before],
                sample_times[number_after],
                xtol=time_tolerance,
                rtol=_STICK_EDGE_ROUNDOFF_SHARE,
            )
            begin_times.append(float(crossing_time))
            directions.append(int(direction_at_samples[number_after]))
    return list(zip(begin_times, [*begin_times[1:], end_time], directions, strict=True))


@dataclass(frozen=True)
class _ForceAbovePiece:
    """Q - M(P) along a load segment while P is within one piece of the memory curve, as a function
    of time.

    M(eta) is the tangential force of the flat punches up to the load eta. A piece is a line, a
    parabola, or an arc: the course of the curved load path itself.
    """

    memory_piece: Piece
    segment: LoadSegment

    @property
    def is_line(self) -> bool:
        """Whether the piece is straight: no arc, and no `bend`, half of d2M/d eta2."""
        return self.memory_piece.arc_times is None and self.memory_piece.bend == 0

    @property
    def along_line(self) -> Combination:
        """The load combination Q - slope P, which is constant along the line of the piece's slope
        dM/d eta at its `anchor`.
        """
        return Combination(-self.memory_piece.slope, 1.0)

    def __call__(self, time: ArrayLike) -> Array:
        """Q - M(P) at times of the segment, any shape [force per thickness].

        The `anchor` is the instant of the path (P and Q) from which the piece is measured. Of a
        line it is the change of Q - slope P since then.
        """
        memory_piece = self.memory_piece
        if self.is_line:
            return combination_change(memory_piece.anchor, self.segment, self.along_line, time)
        normal_load, tangential_load = self.segment.loads(time)
        return tangential_load - force_on_piece(
            memory_piece,
            np.clip(normal_load, memory_piece.bottom_load, memory_piece.anchor.normal_load),
        )

    def sample_times(self, begin: float, end: float) -> Array:
        """Ascending times from `begin` to `end` at which the sign of Q - M(P) is looked at: three
        along a line, 33 along a curved piece, and turning points of Q - slope P, except on an arc.
        """
        # _SAMPLES_OF_CURVED_PIECE: 33
        n_samples = 3 if self.is_line else _SAMPLES_OF_CURVED_PIECE
        turning_times: Sequence[float] = []
        if self.memory_piece.arc_times is None:
            turning_times = self.segment.turning_points(self.along_line)
        turning_times_inside = [time for time in turning_times if begin < time < end]
        return np.unique([*np.linspace(begin, end, n_samples), *turning_times_inside])


@dataclass(frozen=True)
class CycleOfPath:
    """One cycle of a load path: its load segments, and how much later than their own time it is,
    whole periods.
    """

    segments: tuple[LoadSegment, ...]
    delay: float = 0.0


@dataclass(frozen=True, eq=False)
class History:
    """Friction history of a load path: time spans of full stick, or of slip in one direction, of
    its initial loading and of the cycles after it.

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
    ellipse_of_cycle
        the load segment, an ellipse in P and Q, where that is the whole cycle; None for others
    """

    loading: tuple[Span, ...]
    cycles: tuple[tuple[Span, ...], ...]
    states: tuple[Curve, ...]
    steady_from: int | None
    period: float | None = None
    covered: tuple[int, ...] = (0,)
    ellipse_of_cycle: LoadSegment | None = None

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """All spans in the order of time."""
        return (*self.loading, *(span for cycle in self.cycles for span in cycle))

    @property
    def largest_load(self) -> float:
        """The largest P at the ends of spans [force per thickness]."""
        return max(max(span.begin.normal_load, span.end.normal_load) for span in self.spans)

    @property
    def repeats(self) -> bool:
        """Whether cycles after the steady one are copies."""
        return self.period is not None

    @property
    def is_long_measurement(self) -> bool:
        """False: a curved path is no measured series, which would be answered at its rows."""
        return False

    def default_times(self, last_cycle_only: bool, _thins_rows: bool = False) -> tuple[Array, int]:
        """Instants of the answer where the user gives none, ascending: about 400 a cycle and 100 of
        the initial loading, evenly spread over each time span of stick or slip, with its ends.

        With them 0, the number of rows of a measured series that are left out: a curved path has no
        rows. With `last_cycle_only` only the last of the `cycles` counts. A span's `delay` is how
        much later it is than its segment.
        """
        # spans of stick or slip, of each cycle and of the initial loading
        spans_of_parts = list(self.cycles[-1:])
        if not last_cycle_only:
            spans_of_parts = list(self.cycles)
            if self.loading:
                spans_of_parts.append(self.loading)
        times_of_parts = []
        for spans in spans_of_parts:
            ends_of_spans = np.array([spans[0].begin.time, *(span.end.time for span in spans)])
            times_of_parts.append(
                evenly_spaced_times(ends_of_spans, is_initial_loading=spans is self.loading)
                + spans[0].delay
            )
        return np.unique(np.concatenate(times_of_parts)), 0

    def snapshot(self, time: Array) -> Snapshot:
        """Friction state at instants (n,) of the followed path: P, Q, load P - P_c of the slip
        zones, direction of slip, and the memory curve.

        The memory curve M(eta) is the tangential force of the flat punches up to the load eta. P_c
        is the load at the stick edge. An instant between two time spans of stick or slip belongs to
        the one that ends there. Instants beyond the followed cycles are brought back by whole
        periods.

        Raises
        ------
        InputError
            For a time outside the path.
        """
        span_number_of_instant, times_in_segments = self._spans_at(time)
        # times of each span, in the time of its load segments
        order_by_span = np.argsort(span_number_of_instant, kind="stable")
        span_numbers, first_position_of_span = np.unique(
            span_number_of_instant[order_by_span], return_index=True
        )
        times_of_spans = np.split(times_in_segments[order_by_span], first_position_of_span[1:])
        # states in the order of the spans
        snapshot = snapshot_of(
            (self.spans[span_number_of_times], times)
            for span_number_of_times, times in zip(span_numbers, times_of_spans, strict=True)
        )

        # back to the order of the instants
        order_in_time = np.argsort(order_by_span)
        column_names = ("time", "load", "force", "slip_zone_load", "direction", "piece_number")
        return replace(
            snapshot, **{name: getattr(snapshot, name)[order_in_time] for name in column_names}
        )

    def _spans_at(self, time: Array) -> tuple[Array, Array]:
        """Number of the time span of stick or slip that each instant belongs to, and the instant in
        the time of that span's load segment, (n,) each.

        An instant between two spans belongs to the one that ends there. A span's `delay` is how
        much later it is than its segment, a number of whole periods. InputError for a time outside
        the path.
        """
        spans = self.spans
        span_begin_times = np.array([span.begin.time for span in spans])
        span_end_times = np.array([span.end.time for span in spans])
        span_delays = np.array([span.delay for span in spans])
        # ends of the spans in the time of the path
        span_end_times_in_path = span_end_times + span_delays
        path_time, time_slack = time_in_followed_path(
            time,
            float(span_begin_times[0] + span_delays[0]),
            float(span_end_times_in_path[-1]),
            self.period,
        )
        # Minus the slack: a turning point that is right to round-off still belongs to the span
        # that it ends.
        span_number = np.minimum(
            np.searchsorted(span_end_times_in_path, path_time - time_slack, side="left"),
            len(spans) - 1,
        )
        times_in_segments = np.clip(
            path_time - span_delays[span_number],
            span_begin_times[span_number],
            span_end_times[span_number],
        )
        return span_number, times_in_segments


def follow(
    loading_segments: Sequence[LoadSegment], cycles_of_path: Iterable[CycleOfPath], friction: float
) -> History:
    """Friction history of an initial loading and of the cycles after it: up to the first cycle that
    ends in the state in which it began, if there is one; `friction` is f.

    States agree where the memory curves do, within a tolerance that is smaller where less slips in
    the cycle. A memory curve M(eta) is the tangential force of the flat punches up to the load eta.
    A cycle holds its load segments, and its `delay`: how much later it is than their own time. The
    loads must be admissible, |Q| <= f P and P >= 0.
    """
    # spans of stick and slip, and the memory curve at their end; None: not yet in contact
    loading_spans, memory_curve = spans_along(None, loading_segments, friction, 0.0)
    curves_between_cycles = [memory_curve]
    spans_of_cycles = []
    steady_from = None
    for cycle_number, cycle in enumerate(cycles_of_path):
        curve_at_begin = memory_curve
        spans, memory_curve = spans_along(curve_at_begin, cycle.segments, friction, cycle.delay)
        spans_of_cycles.append(spans)
        curves_between_cycles.append(memory_curve)
        # the less P - P_c over P in the cycle, the smaller; P_c is the load at the stick edge
        memory_tolerance = repeat_tolerance(slip_zone_share(spans))
        if is_same_memory(curve_at_begin, memory_curve, friction, memory_tolerance):
            steady_from = cycle_number
            break
    return History(loading_spans, tuple(spans_of_cycles), tuple(curves_between_cycles), steady_from)


def is_plain_ellipse(segment: LoadSegment) -> bool:
    """Whether a segment is the cycle of an `EllipseLoad`, from the paper's point A on; one of a
    `HarmonicLoad` starts at time 0.
    """
    return segment.ellipse is not None and segment.ellipse.origin == 0 and segment.start != 0


def history_of(
    path: LoadPath, friction: float, n_cycles: int, time: Array | None = None
) -> History:
    """Friction history of a load path, followed for as many cycles as the instants `time` (n,)
    need; without them until a cycle ends as it began, `n_cycles` at most.

    In the context `histories_kept` a cached history of the same path is taken instead of following
    the path again; so is one of more cycles that became steady within as many. A history's
    `covered` lists, for each whole cycle that the answer covers, the number of the solved cycle
    that it is or copies.
    """
    most_cycles = 0
    n_whole_cycles = 0
    if path.period is not None:
        most_cycles, n_whole_cycles = cycles_to_follow(
            path.cycle_start, path.period, n_cycles, time
        )
    # by path and friction, then by the most cycles that were followed; None where nothing is cached
    cached_histories = _kept_histories.get()
    if cached_histories is None:
        cached_histories = {}
    histories_of_path = cached_histories.setdefault((path, friction), {})
    history = histories_of_path.get(most_cycles)
    for most_cycles_of_cached_history, cached_history in histories_of_path.items():
        # A history that became steady within these cycles holds no further ones.
        if len(cached_history.cycles) <= most_cycles < most_cycles_of_cached_history:
            history = cached_history
    if history is None:
        history = histories_of_path[most_cycles] = _followed_path(path, friction, most_cycles)
    if path.period is None:
        return history
    n_solved_cycles = len(history.cycles)
    n_covered_cycles = n_whole_cycles or n_solved_cycles
    # Cycles after the last one that was solved are copies of it.
    solved_cycle_number_of_covered_cycle = tuple(
        min(cycle_number, n_solved_cycles - 1) for cycle_number in range(n_covered_cycles)
    )
    return replace(history, covered=solved_cycle_number_of_covered_cycle)


@contextmanager
def histories_kept() -> Iterator[None]:
    """Context in which friction histories are cached by load path and friction: a path that is
    asked for again is not followed again.
    """
    token_of_cache = _kept_histories.set({})
    try:
        yield
    finally:
        _kept_histories.reset(token_of_cache)


def _followed_path(path: LoadPath, friction: float, most_cycles: int) -> History:
    """Friction history of a load path, of its initial loading and `most_cycles` cycles at most; f
    is `friction`. A path without a period counts as one cycle.

    InputError for a path with bulk stress or tilt, after which one memory curve (tangential force
    carried up to each load) is not the whole friction history.
    """
    if path.has_bulk_or_tilt:
        raise InputError(
            "load: half-plane theory with one memory curve takes neither bulk stress nor tilt"
        )
    # InadmissibleLoadError at the first bad instant
    require_admissible([*path.initial_loading, *path.cycle], friction)
    if path.period is None:
        return follow((), [CycleOfPath(path.initial_loading)], friction)
    # each cycle is whole periods later than the first
    cycles = (CycleOfPath(path.cycle, k * path.period) for k in range(most_cycles))
    history = follow(path.initial_loading, cycles, friction)
    # one segment, the ellipse of P and Q of an `EllipseLoad`
    is_ellipse = len(path.cycle) == 1 and is_plain_ellipse(path.cycle[0])
    ellipse_of_cycle = path.cycle[0] if is_ellipse else None
    return replace(history, period=path.period, ellipse_of_cycle=ellipse_of_cycle)


def cycles_to_follow(
    start_time: float, period: float, n_cycles: int, time: Array | None
) -> tuple[int, int]:
    """Number of cycles that must be followed at most for the instants `time` (n,), and number of
    whole cycles up to the last instant.

    If that is within the first cycle, the second number is 0 and the first at least `n_cycles`.
    Without instants the numbers are `n_cycles` and 0. The first cycle begins at time `start_time`.
    An instant counts as an end of a cycle within 1e-9 of the period.
    """
    if time is None:
        return n_cycles, 0
    periods_to_last_instant = (float(np.max(time)) - start_time) / period
    n_whole_cycles = max(math.floor(periods_to_last_instant + INSTANT_SLACK_SHARE), 0)
    n_begun_cycles = math.ceil(periods_to_last_instant - INSTANT_SLACK_SHARE)
    if n_whole_cycles:
        return max(n_begun_cycles, 0), n_whole_cycles
    return max(n_cycles, n_begun_cycles), 0


def time_in_followed_path(
    time: Array, start_time: float, end_time: float, period: float | None
) -> tuple[Array, float]:
    """Instants (n,) brought back by whole periods into the followed part of a load path. Also the
    time by which they may still lie outside of it, by round-off.

    The followed part runs from time `start_time` to `end_time`. Later instants of a path without a
    `period` are refused. INSTANT_SLACK_SHARE is 1e-9.

    Raises
    ------
    InputError
        For a time outside the path.
    """
    time_slack = INSTANT_SLACK_SHARE * (end_time - start_time)
    path_time = time
    if period is not None:
        path_time = time - period * np.maximum(
            np.ceil((time - end_time - time_slack) / period), 0.0
        )
    if np.any(path_time < start_time - time_slack) or np.any(path_time > end_time + time_slack):
        raise InputError(
            f"time: outside the load path, which runs from {start_time:.6g} to {end_time:.6g}"
        )
    return path_time, time_slack


def evenly_spaced_times(span_ends: Array, *, is_initial_loading: bool) -> Array:
    """Times evenly spaced within each of n spans of time between `span_ends` (n + 1,), ascending:
    about 400 in all for a cycle, 100 for the initial loading.

    A span has its middle and both its ends at least. The end of a span and the start of the next
    are both there.
    """
    n_instants = _INSTANTS_OF_LOADING if is_initial_loading else _INSTANTS_OF_CYCLE
    durations = np.diff(span_ends)
    n_intervals = np.maximum(np.ceil(n_instants * durations / (span_ends[-1] - span_ends[0])), 2)
    times_of_spans = [
        np.linspace(begin_time, end_time, int(n_intervals_of_span) + 1)
        for begin_time, end_time, n_intervals_of_span in zip(
            span_ends[:-1], span_ends[1:], n_intervals, strict=True
        )
    ]
    return np.concatenate(times_of_spans)


def slip_zone_share(spans: Sequence[Span]) -> float:
    """Largest P - P_c over largest P of some time spans, P_c the load at the stick edge; 0 where
    nothing slips. Both are taken at the ends of the spans, P - P_c half-way too.
    """
    largest_slip_zone_load = max((span.largest_slip_zone_load for span in spans), default=0.0)
    largest_load = max(
        (max(span.begin.normal_load, span.end.normal_load) for span in spans), default=0.0
    )
    return largest_slip_zone_load / largest_load if largest_load > 0 else 0.0


def snapshot_of(spans_and_times: Iterable[tuple[Span, Array]]) -> Snapshot:
    """Friction states at instants of some time spans of a load path, one span after the other; each
    span comes with times (k,) of its load segment.

    A span is a time in full stick or with slip in one direction. A state is P, Q, the load P - P_c
    beyond the stick edge, and the direction of slip. It also has the `sticking_piece`, the piece of
    the memory curve in which the stick edge is. The memory curve M(eta) is the tangential force of
    the flat punches up to the load eta.
    """
    times = []
    normal_loads = []
    tangential_loads = []
    slip_zone_loads = []
    directions = []
    n_times_of_spans = []
    sticking_pieces: list[Curve] = []
    friction = 0.0
    for span, times_in_segment in spans_and_times:
        normal_load, tangential_load = span.segment.loads(times_in_segment)
        # A path that unloads fully may end below 0 by round-off.
        normal_load = np.maximum(normal_load, 0.0)
        times.append(times_in_segment)
        normal_loads.append(normal_load)
        tangential_loads.append(tangential_load)
        slip_zone_loads.append(span.slip_zone_load_at(times_in_segment, normal_load))
        directions.append(span.direction)
        n_times_of_spans.append(len(times_in_segment))
        sticking_pieces.append(span.sticking_piece)
        friction = span.friction
    return Snapshot(
        time=np.concatenate(times),
        load=np.concatenate(normal_loads),
        force=np.concatenate(tangential_loads),
        slip_zone_load=np.concatenate(slip_zone_loads),
        direction=np.repeat(np.array(directions), n_times_of_spans),
        piece_number=np.repeat(np.arange(len(sticking_pieces)), n_times_of_spans),
        sticking_pieces=tuple(sticking_pieces),
        friction=friction,
    )


def corner_times(contact: Contact, span: Span) -> Array:
    """Times within a time span at which an edge of contact or of stick passes a corner of the
    profile, (n,) ascending; two that differ by round-off count once.

    Integrands over time have a kink there. A span is a time in full stick or with slip in one
    direction. At a corner P, or the load P_c at the stick edge, is one of `contact.corner_loads`.
    """
    corner_loads = contact.corner_loads
    if not len(corner_loads):
        return corner_loads
    begin_instant = span.begin
    end_instant = span.end
    # the edge of contact: P is monotonic in the span
    is_passed = (corner_loads > min(begin_instant.normal_load, end_instant.normal_load)) & (
        corner_loads < max(begin_instant.normal_load, end_instant.normal_load)
    )
    # `time_of`: when P has changed so much since the start
    times_of_contact_edge = span.segment.time_of(
        NORMAL_LOAD,
        corner_loads[is_passed] - begin_instant.normal_load,
        begin_instant.time,
        end_instant.time,
    )
    least_time_difference = 1e-12 * max(
        abs(begin_instant.time), abs(end_instant.time), end_instant.time - begin_instant.time
    )
    sorted_times = np.sort(
        np.concatenate([times_of_contact_edge, _times_of_stick_edge_at(corner_loads, span)])
    )
    is_inside_span = (sorted_times - begin_instant.time > least_time_difference) & (
        end_instant.time - sorted_times > least_time_difference
    )
    inner_times = sorted_times[is_inside_span]
    return inner_times[np.diff(inner_times, prepend=-np.inf) > least_time_difference]


def _times_of_stick_edge_at(loads: Array, span: Span) -> Array:
    """Times within a time span of slip at which the load P_c at the stick edge is one of `loads`,
    (k,); empty in a span without slip or without stick.

    In slip of direction s the stick edge is at eta when s Q - f P has grown to s M(eta) - f eta.
    M(eta), the memory curve, is the tangential force of the flat punches up to the load eta.
    `sticking_piece` is the piece of it through which the edge moves, from `bottom_load` to
    `top_load`; loads outside are left out. Both levels count from its `anchor`, the instant of the
    path from which it is measured. f is the friction.
    """
    sticking_piece = span.sticking_piece
    if not span.direction or sticking_piece is None:
        return np.zeros(0)
    loads_on_piece = loads[(loads > sticking_piece.bottom_load) & (loads < sticking_piece.top_load)]
    # levels of s Q - f P, relative to its value at the anchor
    s_q_minus_f_p = slip_combination(span.direction, span.friction)
    level_at_begin = float(
        combination_change(sticking_piece.anchor, span.segment, s_q_minus_f_p, span.begin.time)
    )
    levels_at_loads = slip_combination_on_piece(
        sticking_piece, span.direction, span.friction, loads_on_piece
    )
    return span.segment.time_of(
        s_q_minus_f_p, levels_at_loads - level_at_begin, span.begin.time, span.end.time
    )
