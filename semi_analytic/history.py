"""The march along a load path: which stretch sticks, which slips, which piece of the memory is being erased, and when.

A history is a sequence of spans, in each of which the memory curve keeps its structure: `base` untouched, on it the
uppermost piece `active` up to a load that moves with time (the load itself while P follows the piece, the front P_c in
slip), and in slip a line of slope +-f from there to (P, Q). Everything that is asked of a history later is evaluated span
by span, for many instants at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InadmissibleLoadError, Leg
from semi_analytic.legs import NORMAL_LOAD, Instant, change, change_from, instant, level, rate, stretches, time_of
from semi_analytic.memory import Curve, Piece, append, clip, cut, flat, level_on, same, slipped_load
from semi_analytic.rounding import repeats_within, slipped_share
from semi_analytic.sides import sides

Array = NDArray[np.float64]

# Share of the largest load, or of the rates of P and Q, below which a difference is rounding.
_ROUNDING = 1e-14
# Share of a stretch of time, or of a level, within which two instants are one.
_NEAR = 1e-14
# Share of f P by which a front may miss the end of the piece that it meets.
_LAST_DIGITS = 2e-15


@dataclass(frozen=True, eq=False)
class Span:
    """A span of time in which the memory curve keeps its structure.

    Attributes
    ----------
    begin, end : its ends on the load path, in the time of the leg
    delay : what makes the leg's time the history's time
    direction : +1 forward slip, -1 reverse slip, 0 no slip
    active : the uppermost piece that is left below the line of slip; None if the front is at P_c = 0
    friction : f
    """

    begin: Instant
    end: Instant
    delay: float
    direction: int
    active: Curve
    friction: float

    @property
    def leg(self) -> Leg:
        """The leg of the load path that is being travelled."""
        return self.begin.leg

    @property
    def base(self) -> Curve:
        """What the span leaves untouched."""
        return self.active.below if self.active is not None else None

    def slipped(self, time: ArrayLike) -> Array:
        """P - P_c >= 0 at times of the leg; 0 where nothing slips."""
        t = np.asarray(time, dtype=float)
        return self.slipped_at(t, self.leg.loads(t)[0])

    def slipped_at(self, t: Array, load: Array) -> Array:
        """The same where P is known."""
        if self.direction == 0:
            return np.zeros(t.shape)
        if self.active is None:
            return load
        lag = slipped_load(self.active, self.direction, self.friction, self.leg, t)
        return np.clip(lag, np.maximum(load - self.active.top, 0.0), load - self.active.bottom)

    @cached_property
    def deepest(self) -> float:
        """Largest P - P_c at its ends and half-way; 0 where nothing slips."""
        if not self.direction:
            return 0.0
        return float(np.max(self.slipped(np.linspace(self.begin.time, self.end.time, 3))))

    def curve(self, time: float) -> Curve:
        """The memory curve at a time of the leg."""
        now = instant(self.leg, time)
        if self.direction == 0:
            return cut(self.active, now.normal)
        return clip(self.active, self.direction, self.friction, now, float(self.slipped(time)))


@dataclass(frozen=True, eq=False)
class History:
    """The spans of a way in and of the cycles after it.

    Attributes
    ----------
    way_in : spans before the first cycle
    cycles : spans of each solved cycle
    states : memory curve at the start of each cycle and at the end of the last
    steady_from : index of the first cycle that ends in the state it started from, None if none did
    """

    way_in: tuple[Span, ...]
    cycles: tuple[tuple[Span, ...], ...]
    states: tuple[Curve, ...]
    steady_from: int | None

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """All spans in the order of time."""
        return (*self.way_in, *(span for cycle in self.cycles for span in cycle))


def check(legs: Sequence[Leg], friction: float) -> None:
    """Raise InadmissibleLoadError at the first instant of gross sliding or separation on `legs`.

    |Q| = f P is admitted, to 1e-14 of f times the largest load: in any unit, for any f.
    """
    scale = max(abs(float(leg.loads(time)[0])) for leg in legs for time in (leg.start, leg.end))
    for leg in legs:
        for begin, end in stretches(leg, friction):
            _check_stretch(leg, begin, end, friction, _ROUNDING * scale)


def _check_stretch(leg: Leg, begin: float, end: float, friction: float, slack: float) -> None:
    last = instant(leg, end)
    limits = [(NORMAL_LOAD, -last.normal, "separation", slack)]
    limits += [
        (
            level(s, friction),
            s * last.tangential - friction * last.normal,
            "gross sliding",
            slack * friction,
        )
        for s in (1, -1)
    ]
    broken = []
    for what, excess, reason, tolerance in limits:
        if excess > tolerance:
            growth = -1.0 if what is NORMAL_LOAD else 1.0
            total = growth * float(change(leg, what, end, begin))
            time = float(time_of(leg, what, growth * (total - excess), begin, end))
            broken.append((time, reason))
    if broken:
        # Where P runs out both limits of friction are met at the same instant: that is separation.
        earliest = min(time for time, _ in broken) + _NEAR * (end - begin)
        time, reason = next(entry for entry in broken if entry[0] <= earliest)
        where = instant(leg, time)
        seen = (last.time, last.normal, last.tangential)  # P, u and v are monotonic up to there
        raise InadmissibleLoadError(reason, time, where.normal, where.tangential, friction, seen)


def march(curve: Curve, legs: Sequence[Leg], friction: float, delay: float) -> tuple[tuple[Span, ...], Curve]:
    """Spans of the legs, and the memory curve at their end."""
    spans: list[Span] = []
    for leg in legs:
        for begin, end in stretches(leg, friction):
            for span in _stretch(curve, leg, begin, end, friction, delay):
                spans.append(span)
                curve = span.curve(span.end.time)
    return tuple(spans), curve


def _stretch(curve: Curve, leg: Leg, begin: float, end: float, friction: float, delay: float) -> Iterator[Span]:
    """Spans of a stretch on which neither P, u nor v turns round."""
    middle = (begin + end) / 2
    normal, tangential = (float(part) for part in leg.rates(middle))
    noise = _ROUNDING * (abs(tangential) + friction * abs(normal))
    forward, reverse = (float(rate(leg, level(s, friction), middle)) > noise for s in (1, -1))
    first, last = instant(leg, begin), instant(leg, end)
    if normal > 0 and not (forward or reverse):
        yield Span(first, last, delay, 0, append(curve, leg, begin, last), friction)
    elif normal < 0 and forward == reverse:
        yield from _unload(curve, first, last, friction, delay)
    elif forward or reverse:
        yield from _slip(curve, 1 if forward else -1, first, last, friction, delay)
    else:
        yield Span(first, last, delay, 0, curve, friction)


def _slip(curve: Curve, direction: int, first: Instant, last: Instant, friction: float, delay: float) -> Iterator[Span]:
    """Spans of slip in one direction: the front passes down through the pieces of the curve."""
    leg, what, begin = first.leg, level(direction, friction), first
    total, last_digits = float(change(leg, what, last.time, first.time)), _LAST_DIGITS * friction * last.normal
    # What slips already is at the limit, and the front is below it.
    if curve is not None and flat(curve, direction, friction):
        curve = curve.below
    while curve is not None:
        if flat(curve, direction, friction):
            if total <= last_digits:  # nothing but rounding would take the front through it: it stays at its upper end
                curve = Piece(curve, curve.top, first, -direction * friction)
                break
            curve = curve.below
            continue
        start = float(change_from(curve.anchor, leg, what, first.time))
        bottom = float(level_on(curve, direction, friction, curve.bottom))
        remaining = bottom - start
        # A front that meets the lower end of the piece at the very end of the stretch, to rounding, has not passed it: what lies
        # below may be at the limit already, and the front would jump through it.
        if total <= remaining + _NEAR * (abs(bottom) + abs(start)) + last_digits:
            break
        passed = instant(leg, float(time_of(leg, what, remaining, first.time, last.time)))
        if passed.time > begin.time:
            yield Span(begin, passed, delay, direction, curve, friction)
            begin = passed
        curve = curve.below
    if last.time > begin.time:
        yield Span(begin, last, delay, direction, curve, friction)


def _unload(curve: Curve, first: Instant, last: Instant, friction: float, delay: float) -> Iterator[Span]:
    """Spans of a stretch with P falling and |dQ/dP| <= f: slip to the side of the curve on which the path runs.

    The admissible cones of later points lie inside those of earlier ones, so the state is that of one step; only the
    direction may change, where the path crosses the curve.
    """
    for begin, end, direction in sides(curve, first, last, friction):
        a, b = instant(first.leg, begin), instant(first.leg, end)
        if direction:
            for span in _slip(curve, direction, a, b, friction, delay):
                yield span
                curve = span.curve(span.end.time)
        else:
            yield from _retrace(curve, a, b, friction, delay)
            curve = cut(curve, b.normal)


def _retrace(curve: Curve, first: Instant, last: Instant, friction: float, delay: float) -> Iterator[Span]:
    """Spans of unloading along the curve itself: no slip."""
    begin = first
    while curve is not None and curve.bottom > last.normal:
        drop = curve.bottom - first.normal
        passed = instant(first.leg, float(time_of(first.leg, NORMAL_LOAD, drop, first.time, last.time)))
        if passed.time > begin.time:
            yield Span(begin, passed, delay, 0, curve, friction)
            begin = passed
        curve = curve.below
    if last.time > begin.time:
        yield Span(begin, last, delay, 0, curve, friction)


@dataclass(frozen=True)
class Turn:
    """One revolution: its legs, and what makes their time the history's time."""

    legs: tuple[Leg, ...]
    delay: float = 0.0


def follow(way_in: Sequence[Leg], turns: Iterable[Turn], friction: float, *, repeat: bool = True) -> History:
    """The history of a way in and of revolutions; where they `repeat` it stops after the first that ends as it began.

    Raises
    ------
    InadmissibleLoadError
        Gross sliding or separation, with the instant and the loads.
    """
    spans, curve = march(None, way_in, friction, 0.0)
    states, cycles, steady = [curve], [], None
    for number, turn in enumerate(turns):
        cycle, curve = march(curve, turn.legs, friction, turn.delay)
        cycles.append(cycle)
        states.append(curve)
        if steady is None and same(states[-2], curve, friction, repeats_within(slipped_share(cycle))):
            steady = number
            if repeat:
                break
    return History(spans, tuple(cycles), tuple(states), steady)
