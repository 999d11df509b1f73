"""Friction work, over the whole contact and point by point, of any history; and a second way to the former.

# notation: A = 2/E*; w = +-Q - f P, which grows in slip; P_c load at the front of slip, c = a(P_c); P_x load at which a = |x|

    W    = (f A/pi) int w' Lam(P, P_c) dt,                  Lam = int_{P_c}^P ln(a(eta)/c) d eta
    W(x) = (f A/pi) int p(x, P) w' arccosh(|x|/c) dt        over the times with c < |x| < a(P)
    W    = closed-int Q dU                                  over a steady cycle

Each span of slip is integrated in time by one rule for singular ends: roots at the edges of the contact, the logarithm of gross
sliding, P close to 0 all lie at an end of a span or beyond it. On legs and arcs without formulas the front may run unevenly in the
middle of a span as well, and so may all edges where P(a) hardly grows at one load: there the rule is applied to halves, and to
halves of these, until that changes nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import EllipseLeg, ParabolaLeg, StraightLeg
from semi_analytic.contact import Contact, bends_anywhere
from semi_analytic.corners import smooth_spans
from semi_analytic.fields import Integrals
from semi_analytic.history import Span
from semi_analytic.legs import LEAST, NORMAL_LOAD, Combination, change, change_from, level, rate, time_of
from semi_analytic.memory import level_on
from semi_analytic.quadrature import graded
from semi_analytic.rounding import LAST_DIGITS
from semi_analytic.settling import SETTLED, Settled, settled
from semi_analytic.snapshot import take

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_CHUNK = 256
_STORED = 1e-3
_DIGITS_OF_SHIFT = 5e-16


class Split(NamedTuple):
    """Friction work done while slipping forward and while slipping in reverse, and an estimate of the error of both together."""

    forward: Array
    reverse: Array
    error: Array

    @property
    def total(self) -> Array:
        """Both together."""
        return self.forward + self.reverse


def global_dissipation(contact: Contact, modulus: float, spans: Sequence[Span]) -> Split:
    """Friction work of the spans [energy per unit thickness]."""
    slipping = [span for span in smooth_spans(contact, spans) if span.direction and span.active is not None]
    works, error = np.zeros(len(slipping)), 0.0
    straight = np.array([_is_straight(span) and not uneven(contact, span) for span in slipping], dtype=bool)
    for number in np.flatnonzero(~straight):
        span = slipping[number]
        works[number] = _work_of_curved(contact, span, [span.begin.time], [span.end.time])[0]
    if np.any(straight):
        works[straight] = _work_of_straight(contact, [span for span, here in zip(slipping, straight, strict=True) if here])
    # One size for all: a short span by itself may be all rounding, and would never settle to its own.
    size = float(np.sum(works))
    for number in np.flatnonzero(~straight):
        if uneven(contact, slipping[number]):
            works[number], doubt = _settled_work(contact, slipping[number], size)
            error += doubt
    forward = np.array([span.direction > 0 for span in slipping], dtype=bool)
    factor = 2 / (math.pi * modulus)
    return Split(factor * np.sum(works[forward]), factor * np.sum(works[~forward]), np.asarray(factor * error))


def _work_of_curved(contact: Contact, span: Span, begin: ArrayLike, end: ArrayLike) -> Array:
    """f int w' Lam dt over parts of one span, from begin[k] to end[k]: (n,)."""
    times, weights = graded(begin, end)
    area = contact.log_area(span.leg.loads(times)[0], span.slipped(times))
    growth = rate(span.leg, level(span.direction, span.friction), times)
    return np.asarray(span.friction * np.sum(weights * np.maximum(growth, 0.0) * area, axis=-1))


def _settled_work(contact: Contact, span: Span, size: float) -> tuple[float, float]:
    """The same over the whole span, settled to 1e-12 of `size` or to its own rounding, and its error."""
    allowed = max(SETTLED * size, float(_rounding(span, contact.log_area)[0]))

    def work(_: Indices, begin: Array, end: Array) -> Array:
        return _work_of_curved(contact, span, begin, end)

    value, error = settled(work, [span.begin.time], [span.end.time], allowed)
    return float(value[0]), float(error[0])


def _rounding(span: Span, reach: Callable[[float, Array], Array]) -> Array:
    """What the last digits of P leave in f times the growth of a span's level times reach(P, P - P_c): (k,)."""
    load = max(span.begin.normal, span.end.normal)
    digits = LAST_DIGITS * load
    growth = abs(float(change(span.leg, level(span.direction, span.friction), span.end.time, span.begin.time)))
    slipped = float(np.max(span.slipped(np.linspace(span.begin.time, span.end.time, 3))))
    known, doubtful = reach(load, np.array([[slipped], [slipped + digits]]))
    return span.friction * ((growth + span.friction * digits) * doubtful - growth * known)


def uneven(contact: Contact, span: Span) -> bool:
    """Whether the load, or the front along an arc, runs by no formula, or the edges of contact and stick do at any load."""
    if bends_anywhere(contact):
        return True
    arc = span.active is not None and span.active.arc is not None
    return not isinstance(span.leg, EllipseLeg) and (arc or not isinstance(span.leg, StraightLeg | ParabolaLeg))


def _is_straight(span: Span) -> bool:
    """Whether P and P - P_c are linear in time."""
    piece = span.active
    return piece is not None and piece.arc is None and piece.bend == 0 and isinstance(span.leg, StraightLeg)


def _work_of_straight(contact: Contact, spans: Sequence[Span]) -> Array:
    """f int w' Lam dt of spans in which P and P - P_c are linear in time, all at once: (m,) [force^2 per thickness^2]."""
    ends = [np.array([span.begin.time, span.end.time]) for span in spans]
    load = np.array([(span.begin.normal, span.end.normal) for span in spans])
    slipped = np.array([span.slipped_at(times, pair) for span, times, pair in zip(spans, ends, load, strict=True)])
    growth = [float(change(span.leg, level(span.direction, span.friction), span.end.time, span.begin.time)) for span in spans]
    part, weight = graded(0.0, 1.0)
    works = []
    for chunk in range(0, len(spans), _CHUNK):
        here = slice(chunk, chunk + _CHUNK)
        p, d = (values[here, :1] * (1 - part) + values[here, 1:] * part for values in (load, slipped))
        works.append(np.sum(weight * contact.log_area(p, d), axis=1))
    return spans[0].friction * np.maximum(np.array(growth), 0.0) * np.concatenate(works)


def pointwise_dissipation(contact: Contact, modulus: float, spans: Sequence[Span], x: Array) -> Split:
    """Friction work of the spans at |x| = `x` (k,): shape (k,) [energy per area]."""
    work = {1: np.zeros(len(x)), -1: np.zeros(len(x))}
    edge_load = contact.load(x)
    todo = []
    for span in smooth_spans(contact, spans):
        if span.direction and span.active is not None:
            begin, end = slip_times(span, edge_load)
            here = np.flatnonzero(end > begin)
            if len(here):
                rough = _work_at(contact, span, x[here], edge_load[here], begin[here], end[here])
                work[span.direction][here] += rough
                if uneven(contact, span):
                    todo.append((span, here, begin, end, rough))
    error, size = np.zeros(len(x)), float(np.max(work[1] + work[-1], initial=0.0))
    for span, here, begin, end, rough in todo:
        value, doubt = _settled_at(contact, span, x[here], edge_load[here], begin[here], end[here], size)
        work[span.direction][here] += value - rough
        error[here] += doubt
    factor = 2 / (math.pi * modulus)
    return Split(factor * work[1], factor * work[-1], factor * error)


def _settled_at(contact: Contact, span: Span, x: Array, edge_load: Array, begin: Array, end: Array, size: float) -> Settled:
    """Work of one span at `x` (k,) from begin[k] to end[k], settled to 1e-12 of `size` or to its own rounding."""

    def part(which: Indices, low: Array, high: Array) -> Array:
        return _work_at(contact, span, x[which], edge_load[which], low, high)

    def weighed(load: float, slipped: Array) -> Array:
        reach = contact.reach(x, np.maximum(edge_load - (load - slipped), 0.0), load - slipped)
        return np.asarray(contact.pressure(x, load) * reach)

    return settled(part, begin, end, max(SETTLED * size, float(np.max(_rounding(span, weighed)))))


def slip_times(span: Span, edge_load: Array) -> tuple[Array, Array]:
    """When, within a span, points are in contact and outside the front; end <= begin if never."""
    assert span.active is not None
    leg, what, first, last = span.leg, level(span.direction, span.friction), span.begin, span.end
    top, bottom = span.active.top, span.active.bottom
    front = level_on(span.active, span.direction, span.friction, np.clip(edge_load, bottom, top))
    amount = front - float(change_from(span.active.anchor, leg, what, first.time))
    begin = time_of(leg, what, amount, first.time, last.time)
    begin = np.where(edge_load >= top, first.time, np.where(edge_load <= bottom, last.time, begin))
    meets = time_of(leg, NORMAL_LOAD, edge_load - first.normal, first.time, last.time)
    # Of the change itself: where P hardly moves, the last digits of both loads may say that it falls while it grows.
    growth = float(change(leg, NORMAL_LOAD, last.time, first.time))
    if growth >= LEAST:
        return np.maximum(begin, np.where(edge_load >= last.normal, last.time, meets)), np.full(begin.shape, last.time)
    inside = edge_load < max(first.normal, last.normal)
    end = meets if growth <= -LEAST else np.full(begin.shape, last.time)
    return begin, np.where(inside, end, begin)


def _work_at(contact: Contact, span: Span, x: Array, edge_load: Array, begin: Array, end: Array) -> Array:
    times, weights = graded(begin, end)
    load = span.leg.loads(times)[0]
    front = load - span.slipped(times)
    reach = contact.reach(x[:, None], np.maximum(edge_load[:, None] - front, 0.0), front)
    growth = np.maximum(rate(span.leg, level(span.direction, span.friction), times), 0.0)
    return span.friction * np.sum(weights * contact.pressure(x[:, None], load) * growth * reach, axis=-1)


def closed_integral(contact: Contact, modulus: float, spans: Sequence[Span]) -> float:
    """Closed integral of Q dU over the spans of a steady cycle [energy per unit thickness]."""
    return closed_integral_and_rounding(contact, modulus, spans)[0]


def closed_integral_and_rounding(contact: Contact, modulus: float, spans: Sequence[Span]) -> tuple[float, float]:
    """The same, and what the last digits of the rigid shift U may have left in it.

    Written as -int (U - lambda Q) dQ with any lambda, since the integral of Q dQ vanishes: the datum is set so that the logarithm
    is nothing where the contact is largest. That keeps the digits where it hardly varies, as for a face that is nearly all flat.
    """
    largest = max(max(span.begin.normal, span.end.normal) for span in spans)
    contact = replace(contact, datum_length=float(contact.half_width(largest)) / 2)
    integrals = Integrals(contact, np.zeros(1), "shift")
    offset = float(contact.log_ratio(largest))
    spans = smooth_spans(contact, spans)
    # U is a sum of logarithms times loads up to f P, however little of it changes: its last digits, all along Q.
    size = 2 * abs(float(contact.log_distance(largest))) + abs(offset) * largest
    doubt = _DIGITS_OF_SHIFT * spans[0].friction * size * sum(_travel(span) for span in spans)

    def loop(some: Sequence[Span], rules: Sequence[tuple[Array, Array]]) -> float:
        snapshot = take((span, times) for span, (times, _) in zip(some, rules, strict=True))
        shift = integrals.over(snapshot)[:, 0] - offset * snapshot.force
        rates = [rate(span.leg, Combination(0.0, 1.0), times) * weights for span, (times, weights) in zip(some, rules, strict=True)]
        return -float(np.sum(shift * np.concatenate(rates)))

    def part(span: Span, low: float, high: float) -> float:
        return loop([span], [graded(low, high)])

    even = [span for span in spans if not uneven(contact, span)]
    total = loop(even, [graded(span.begin.time, span.end.time) for span in even]) if even else 0.0
    rough = [(span, part(span, span.begin.time, span.end.time)) for span in spans if uneven(contact, span)]
    # What is stored and given back may be much larger than the rest; a short part by itself may be all rounding.
    size = max(abs(total + sum(value for _, value in rough)), _STORED * sum(abs(value) for _, value in rough))
    total += sum(_settled_loop(partial(part, span), span, max(size, abs(value))) for span, value in rough)
    return 2 / (math.pi * modulus) * total, 2 / (math.pi * modulus) * doubt


def _travel(span: Span) -> float:
    """Way of Q along a span, seen at five instants [force per thickness]."""
    return float(np.sum(np.abs(np.diff(span.leg.loads(np.linspace(span.begin.time, span.end.time, 5))[1]))))


def _settled_loop(work: Callable[[float, float], float], span: Span, size: float) -> float:
    """A part of a closed integral over one span, settled to 1e-12 of `size`."""

    def each(_: Indices, begin: Array, end: Array) -> Array:
        return np.array([work(low, high) for low, high in zip(begin.tolist(), end.tolist(), strict=True)])

    return float(settled(each, [span.begin.time], [span.end.time], SETTLED * size).value[0])
