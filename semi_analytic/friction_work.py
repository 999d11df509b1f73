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
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semi_analytic.contact import Contact, bends_anywhere
from semi_analytic.fields import Integrals
from semi_analytic.history import Span, smooth_spans, take
from semi_analytic.legs import LEAST, NORMAL_LOAD, Combination, change, change_from, level, rate, time_of
from semi_analytic.memory import Snapshot, level_on
from semi_analytic.quadrature import graded
from semi_analytic.roundoff import LAST_DIGITS

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

CONVERGED = 1e-12
# How often a range is halved at most: parts of 1/131,072 of it are left as they are.
_HALVINGS = 17
_STORED = 1e-3
DIGITS_OF_SHIFT = 5e-16
"""Share of the rigid shift U, as a sum of logarithms times loads, that its last digits may be off."""


@dataclass(frozen=True, eq=False)
class Along:
    """What a followed path leaves for an answer, whichever way it was followed.

    Attributes
    ----------
    snapshot : memory curves at the instants; without their pieces where no field needs them
    balance : (n,) M(P) - Q there
    least, slipped_share : least P_c of the last cycle, largest (P - P_c)/P of all that was followed
    each, each_error : (n_cycles,) friction work of the covered cycles, NaN where it was not wanted; largest relative error
    density, density_error : (k,) W(x) of the last cycle, NaN likewise; its error over its largest value
    loop : closed integral of Q dU of the last cycle and what rounding may have left in it; None where it is not steady
    spans : of the last cycle, none for straight steps
    increments : (n,) friction work since the instant before, empty where instants lie between rows
    counts, stick : what was done; how many quadratures were not, since nothing slips
    """

    snapshot: Snapshot
    balance: Array
    least: float
    slipped_share: float
    each: Array
    each_error: float
    density: Array
    density_error: float
    loop: tuple[float, float] | None
    spans: Sequence[Span]
    increments: Array
    counts: dict[str, int]
    stick: int


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
    works = np.array([_work_of_span(contact, span, [span.begin.time], [span.end.time])[0] for span in slipping])
    # One size for all: a short span by itself may be all rounding, and would never converge to its own.
    size, error = float(np.sum(works)), 0.0
    for number, span in enumerate(slipping):
        if uneven(contact, span):

            def part(_: Indices, begin: Array, end: Array, span: Span = span) -> Array:
                return _work_of_span(contact, span, begin, end)

            allowed = max(CONVERGED * size, float(_rounding(span, contact.log_area)[0]))
            found = by_halving(part, [span.begin.time], [span.end.time], allowed)
            works[number] = found.value[0]
            error += float(found.error[0])
    forward = np.array([span.direction > 0 for span in slipping], dtype=bool)
    factor = 2 / (math.pi * modulus)
    return Split(factor * np.sum(works[forward]), factor * np.sum(works[~forward]), np.asarray(factor * error))


def _work_of_span(contact: Contact, span: Span, begin: ArrayLike, end: ArrayLike) -> Array:
    """f int w' Lam dt over parts of one span, from begin[k] to end[k]: (n,)."""
    times, weights = graded(begin, end)
    area = contact.log_area(span.leg.loads(times)[0], span.slipped(times))
    growth = rate(span.leg, level(span.direction, span.friction), times)
    return np.asarray(span.friction * np.sum(weights * np.maximum(growth, 0.0) * area, axis=-1))


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
    return span.leg.ellipse is None and (arc or not (span.leg.is_straight or span.leg.slope_and_bend(span.leg.end)))


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
        at, edge = x[here], edge_load[here]

        def part(which: Indices, low: Array, high: Array, span: Span = span, at: Array = at, edge: Array = edge) -> Array:
            return _work_at(contact, span, at[which], edge[which], low, high)

        def weighed(load: float, slipped: Array, at: Array = at, edge: Array = edge) -> Array:
            reach = contact.reach(at, np.maximum(edge - (load - slipped), 0.0), load - slipped)
            return np.asarray(contact.pressure(at, load) * reach)

        found = by_halving(part, begin[here], end[here], max(CONVERGED * size, float(np.max(_rounding(span, weighed)))))
        work[span.direction][here] += found.value - rough
        error[here] += found.error
    factor = 2 / (math.pi * modulus)
    return Split(factor * work[1], factor * work[-1], factor * error)


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
    ways = [span.leg.loads(np.linspace(span.begin.time, span.end.time, 5))[1] for span in spans]
    doubt = DIGITS_OF_SHIFT * spans[0].friction * size * sum(float(np.sum(np.abs(np.diff(way)))) for way in ways)

    def loop(some: Sequence[Span], rules: Sequence[tuple[Array, Array]]) -> float:
        snapshot = take((span, times) for span, (times, _) in zip(some, rules, strict=True))
        shift = integrals.over(snapshot)[:, 0] - offset * snapshot.force
        rates = [rate(span.leg, Combination(0.0, 1.0), times) * weights for span, (times, weights) in zip(some, rules, strict=True)]
        return -float(np.sum(shift * np.concatenate(rates)))

    even = [span for span in spans if not uneven(contact, span)]
    total = loop(even, [graded(span.begin.time, span.end.time) for span in even]) if even else 0.0
    rough = [(span, loop([span], [graded(span.begin.time, span.end.time)])) for span in spans if uneven(contact, span)]
    # What is stored and given back may be much larger than the rest; a short part by itself may be all rounding.
    size = max(abs(total + sum(value for _, value in rough)), _STORED * sum(abs(value) for _, value in rough))
    for span, value in rough:

        def parts(_: Indices, begin: Array, end: Array, span: Span = span) -> Array:
            return np.array([loop([span], [graded(low, high)]) for low, high in zip(begin.tolist(), end.tolist(), strict=True)])

        total += float(by_halving(parts, [span.begin.time], [span.end.time], CONVERGED * max(size, abs(value))).value[0])
    return 2 / (math.pi * modulus) * total, 2 / (math.pi * modulus) * doubt


def work_over_points(contact: Contact, modulus: float, spans: Sequence[Span], work: float) -> Converged:
    """Integral of W(x) over the whole contact [energy per unit thickness], and its error; `work` is about what it will be.

    Cut at every kink of W(x); where fronts run by no formula W(x) may be steep anywhere, and is found by halving in between.
    """

    def rule(_: Indices, low: Array, high: Array) -> Array:
        x, weight = graded(low, high)
        density = pointwise_dissipation(contact, modulus, spans, x.ravel()).total
        return 2 * np.sum(weight * density.reshape(x.shape), axis=-1)

    marks = kinks(contact, spans)
    if not any(uneven(contact, span) for span in spans):
        whole = float(np.sum(rule(np.arange(len(marks) - 1), marks[:-1], marks[1:])))
        return Converged(np.array(whole), np.array(0.0))
    found = by_halving(rule, marks[:-1], marks[1:], CONVERGED * work)
    return Converged(np.asarray(np.sum(found.value)), np.asarray(np.sum(found.error)))


def kinks(contact: Contact, spans: Sequence[Span]) -> Array:
    """The x >= 0 between which W(x) is smooth, ascending: edges of contact and of stick where a span begins or ends.

    Spans that are cut at the corners of the profile count too: a front at a corner goes on with another speed, which the points
    feel that come into contact at that instant.
    """
    marks = [np.asarray(getattr(contact, "breaks", ()), dtype=float)]
    for span in smooth_spans(contact, spans):
        times = np.array([span.begin.time, span.end.time])
        load = span.leg.loads(times)[0]
        marks += [contact.half_width(load), contact.half_width(np.maximum(load - span.slipped(times), 0.0))]
    every = np.unique(np.concatenate(marks))
    every = every[every <= max(float(np.max(half)) for half in marks[1:])]
    return every[np.diff(every, prepend=-np.inf) > 1e-12 * every[-1]]


class Converged(NamedTuple):
    """Integrals (m,), and an estimate of the error of each: what the last halving changed.

    Covered down to the floor of the rule: `graded` leaves 4e-12 of a part that has a pole beside its end, at whatever distance.
    """

    value: Array
    error: Array


def by_halving(work: Callable[[Indices, Array, Array], Array], begin: ArrayLike, end: ArrayLike, allowed: float) -> Converged:
    """Integrals of m integrands, number k from begin[k] to end[k].

    Parameters
    ----------
    work : work(which (n,), low (n,), high (n,)) gives the integral of integrand which[k] from low[k] to high[k], (n,), by one rule
    begin, end : (m,)
    allowed : the change at which a part has converged, `CONVERGED` of their size where rounding leaves as much. A part of 2^-17 of
        its range, or one that is not finite, is left as it is, and its error shows that.

    >>> def midpoint(which, low, high):
    ...     return (high - low) * (low + high) / 2
    >>> by_halving(midpoint, [0.0, 1.0], [2.0, 3.0], CONVERGED).value.tolist()
    [2.0, 4.0]
    """
    low, high = np.array(begin, dtype=float), np.array(end, dtype=float)
    which = np.arange(len(low))
    value, error = np.zeros(len(low)), np.zeros(len(low))
    rough = work(which, low, high)
    for turn in range(_HALVINGS + 1):
        middle = (low + high) / 2
        left, right = np.split(work(np.tile(which, 2), np.r_[low, middle], np.r_[middle, high]), 2)
        change = np.abs(left + right - rough)
        done = (change <= allowed) | ~np.isfinite(change) | (turn == _HALVINGS)
        np.add.at(value, which[done], (left + right)[done])
        np.add.at(error, which[done], change[done])
        on = ~done
        low, high = np.r_[low[on], middle[on]], np.r_[middle[on], high[on]]
        which, rough = np.tile(which[on], 2), np.r_[left[on], right[on]]
        if not len(which):
            break
    return Converged(value, error)
