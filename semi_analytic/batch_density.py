"""Pointwise dissipation of steady ellipses, and its maxima: the letters and angles of `batch_ellipses`.

# notation: P_x load at which a = |x|; h half-angle about the least load within which x is open, 2 P1 sin^2(h/2) = P_x - P_min

While c < |x| < a(P), W(x) gathers (f A/pi) p(x, P) |rate| arccosh(|x|/c). The point is in contact for pi + h < t < 3 pi - h, and
the front passes it in E-G where sin^2((D - s)/2) = (P_x - P_T)/v, in I-J at s = t_E - h, in J-M where sin^2(s/2) = (P_x - P_T)/u.

Where slip goes on at the least load, W has a kink at a(P_min). With d the distance from it, W goes as d ln|d|: the slope is minus
infinity on both sides. A first maximum, the shoulder, may therefore lie just inside a(P_min) and a second one further out. At the
corners of a profile W may have a kink too. At the edges of contact at E and G it has two derivatives (it goes as d^(5/2)), at those
of I and J more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from semi_analytic.batch_cuts import angles, corner_loads, quadrature_error
from semi_analytic.batch_ellipses import Ellipses, phase_of
from semi_analytic.batch_profiles import BatchContact, Profiles
from semi_analytic.quadrature import graded
from semi_analytic.rounding import LAST_DIGITS, PROMISED

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_CHUNK = 500
_MEMBERS = 256
# Samples between two kinks or events, closer together at both, and what is left of them where a profile has many corners; samples
# beside the kinks, as shares of the smaller part of the slip zone.
_INSIDE = (1 - np.cos(math.pi * np.arange(1, 6) / 6)) / 2
_FEW, _FEW_INSIDE = 8, slice(2, 3)
_BESIDE_KINK = 0.03 * np.power(0.1, np.arange(4))
# Samples that differ by less than this share of the largest, at more than this share of the slip zone, get others in between.
_LEVEL, _CLOSER = 0.01, np.array([0.25, 0.5, 0.75])
# Share of the slip zone within which two samples are one.
_ALIKE = 1e-10
# A maximum is found when W may rise by this share of it only; by every second node of the rule at first.
_NEARLY, _KNOWN = 1e-5, 1e-10
# Each round takes a bracket to a fourth where W is smooth, every other one to half at worst.
_ROUNDS = 40
_EVENLY = np.array([0.21, 0.47, 0.73])
_THREE = np.array([[-1], [0], [1]])
# A second maximum counts where W falls between the two by this share of the larger; samples are good to 1e-6.
_DISTINCT = 1e-3


def density_of(e: Ellipses, contact: BatchContact | Profiles, x: Array, every: int = 1) -> tuple[Array, Array]:
    """Forward and reverse part of W(x) pi E*/(2 f^2), arrays (m,): member k at |x| = x[k], in chunks.

    With `every` = 2 by every second node of the rule, to some 1e-6.
    """
    profiles = contact if isinstance(contact, Profiles) else Profiles.of_one(contact)
    forward, reverse = np.zeros(len(x)), np.zeros(len(x))
    for first in range(0, len(x), _CHUNK):
        here = np.arange(first, min(first + _CHUNK, len(x)))
        forward[here], reverse[here] = _densities(e.take(here[:, None]), profiles.take(here), x[here, None], every)
    return forward, reverse


def _densities(e: Ellipses, profiles: Profiles, x: Array, every: int) -> tuple[Array, Array]:
    """The same for x (m, 1), all at once."""
    contact = profiles.of((slice(None), None))
    edge = contact.load(x)
    share = (edge - e.mean + e.amplitude) / np.where(e.moving, 2 * e.amplitude, 1.0)
    risen = np.where(e.moving, share, np.where(edge > e.mean, 1.0, 0.0))
    away = 2 * np.arcsin(np.sqrt(np.clip(risen, 0.0, 1.0)))
    above, start, turn = np.maximum(edge - e.permanent, 0.0), e.start, e.turn
    passed = [2 * np.arcsin(np.sqrt(np.minimum(above / np.where(size > 0, size, np.inf), 1.0))) for size in (e.v, e.u)]
    first = np.maximum(turn - passed[0], 0.0)
    ranges = {
        "E-G": [(first, np.minimum(turn, math.pi - away - start)), (np.maximum(first, math.pi + away - start), turn)],
        "I-J": [(np.abs(start - away), np.minimum(math.pi - turn, 2 * math.pi - away - start))],
        "J-M": [(np.maximum(0.0, start - math.pi + away), np.minimum(np.minimum(turn, passed[1]), start + math.pi - away))],
    }
    marks = _marks(e, profiles)
    total = {name: np.zeros(len(x)) for name in ranges}
    for name, parts in ranges.items():
        for begin, end in parts:
            cuts = np.concatenate([begin, np.clip(marks[name].T, begin, np.maximum(begin, end)), end], axis=1)
            member, number = np.nonzero(cuts[:, 1:] > cuts[:, :-1])
            if len(member):
                some, low, high = profiles.of(member[:, None]), cuts[member, number], cuts[member, number + 1]
                nodes = graded(low, high, every)
                parts_of_work = _integral(name, e.take(member), some, x[member], edge[member], nodes)
                np.add.at(total[name], member, parts_of_work)
    return total["I-J"] + total["J-M"], total["E-G"]


def _marks(e: Ellipses, profiles: Profiles) -> dict[str, Array]:
    """Where a corner of the profile cuts the phases, (marks, m)."""
    corners = corner_loads(profiles.of(slice(None)))
    if not len(corners):
        return dict.fromkeys(("E-G", "I-J", "J-M"), np.empty((0, len(e.mean))))
    return angles(e.take((slice(None), 0)), np.broadcast_to(corners, (len(corners), len(e.mean))))


def _integral(name: str, e: Ellipses, contact: BatchContact, x: Array, edge: Array, nodes: tuple[Array, Array]) -> Array:
    """int p |rate| arccosh(|x|/c) ds over one range of one phase by the nodes and weights (m, n): (m,)."""
    s, weight = nodes
    growth, slipped, load = phase_of(name, e, s)
    front = np.maximum(load - slipped, 0.0)
    reach = contact.reach(x, np.maximum(edge - front, 0.0), front)
    return np.sum(weight * growth * contact.pressure(x, load) * reach, axis=1)


class Maxima(NamedTuple):
    """The two largest maxima of W(x) pi E*/(2 f^2), arrays (m,).

    Attributes
    ----------
    value, place : the largest, and its |x|; 0 and NaN where nothing slips
    fraction : the same place from the permanent stick edge (0) to the largest contact (1)
    second_value, second_place : the next one; NaN where there is one maximum only
    error : of `value`
    """

    value: Array
    place: Array
    fraction: Array
    second_value: Array
    second_place: Array
    error: Array


def maxima_of(e: Ellipses, contact: BatchContact | Profiles) -> Maxima:
    """The maxima of W(x) of each member."""
    profiles = contact if isinstance(contact, Profiles) else Profiles.of_one(contact)
    found = np.empty((len(Maxima._fields), len(e.mean)))
    for members, some in profiles.groups(len(e.mean), (*profiles.alike, "exponent")):
        for first in range(0, len(members), _MEMBERS):
            part = np.arange(first, min(first + _MEMBERS, len(members)))
            found[:, members[part]] = _maxima(e.take(members[part]), some.take(part))
    return Maxima(*found)


def _maxima(e: Ellipses, profiles: Profiles) -> Maxima:
    """Samples in each piece between kinks and events; the maximum is looked for about every sample above its neighbours."""

    def density(member: Indices, x: Array, every: int = 1) -> Array:
        forward, reverse = density_of(e.take(member), profiles.take(member), x, every)
        return forward + reverse

    points, count = _samples(e, profiles.of(slice(None))), len(e.mean)
    inner, outer = points[:, 0], points[:, -1]
    new = np.diff(points, axis=1, prepend=-np.inf) > _ALIKE * (outer - inner)[:, None]
    member, x = np.nonzero(new)[0], points[new]
    sample = density(member, x, 2)
    spoilt = np.bincount(member, np.isnan(sample), count) > 0
    # Nothing is dissipated at the ends of the slip zone: no maximum is there, and members next to each other stay apart.
    begin = np.flatnonzero(np.diff(member, prepend=-1))
    sample[begin] = sample[np.append(begin[1:], len(x)) - 1] = 0.0
    # Samples are put closer where W is nearly level, lest one of two maxima next to each other is missed.
    scale = (_LEVEL * np.maximum.reduceat(sample, begin))[member[:-1]]
    level = (np.abs(np.diff(sample)) < scale) & (sample[:-1] > scale) & (sample[1:] > scale)
    wide = np.flatnonzero(level & (np.diff(x) > _LEVEL * (outer - inner)[member[:-1]]))
    more = (x[wide] + np.diff(x)[wide] * _CLOSER[:, None]).ravel()
    member = np.concatenate([member, np.tile(member[wide], len(_CLOSER))])
    x, sample = np.concatenate([x, more]), np.concatenate([sample, density(member[len(x) :], more, 2)])
    order = np.lexsort((x, member))
    member, x, sample = member[order], x[order], sample[order]
    number = np.flatnonzero((sample[1:-1] > sample[:-2]) & (sample[1:-1] >= sample[2:])) + 1
    owner = member[number]
    near = _closer(partial(density, every=2), owner, x[number + _THREE], sample[number + _THREE], _NEARLY)[0]
    near, works = _closer(density, owner, near, np.stack([density(owner, row) for row in near]), _KNOWN)
    (top, at), rise = _parabola(near, works), _rise(near, works)
    order, best = np.argsort(top, kind="stable"), np.full(count, -1)
    best[owner[order]] = order
    relative, least = _rounding(e, inner, outer)
    value, error = (np.where(spoilt, np.nan, known) for known in (0.0, least))
    place, second_value, second_place = (np.full(count, np.nan) for _ in range(3))
    some = np.flatnonzero((best >= 0) & ~spoilt)
    largest = best[some]
    value[some], place[some] = top[largest], at[largest]
    rules = np.stack([density(some, place[some], every) for every in (1, 2, 4)])
    error[some] = rise[largest] + top[largest] * (quadrature_error(rules, rules[0]) + relative[some])
    # Other maxima count where W falls in between, and not by its last digits only.
    ends = np.sort(np.stack([number, number[best[owner]]]), axis=0)
    dip = np.minimum.reduceat(sample, ends.T.ravel())[::2] if len(number) else sample
    fall = np.maximum(_DISTINCT * value, 2 * error)
    others = order[(order != best[owner[order]]) & (dip[order] < top[order] - fall[owner[order]])]
    second_value[owner[others]], second_place[owner[others]] = top[others], at[others]
    return Maxima(value, place, (place - inner) / np.where(outer > inner, outer - inner, 1.0), second_value, second_place, error)


def _rounding(e: Ellipses, inner: Array, outer: Array) -> tuple[Array, Array]:
    """Relative error of W(x) by the last digits of P_x, which count for more where P - P_c is small; and a bound of W(x) itself for
    where it is lost in them, the product of p, 2 (u + v) and arccosh(|x|/c) for small d = P - P_c: 2 (u + v) d/(pi a). (m,) each.
    """
    ends, middle = np.maximum(e.u, e.v) * np.sin(e.turn / 2) ** 2, np.sin(np.minimum(math.pi - e.turn, math.pi / 2))
    deepest = np.maximum(ends, 2 * e.amplitude * e.sine * middle)
    slips = deepest > 0
    relative = PROMISED + 3 * LAST_DIGITS * (e.mean + e.amplitude) / np.where(slips, deepest, np.inf)
    return relative, np.where(slips, 2 / math.pi * (e.u + e.v) * deepest / np.where(inner > 0, inner, outer), 0.0)


def _samples(e: Ellipses, contact: BatchContact) -> Array:
    """Points from the permanent stick edge to the largest contact, ascending, some of them equal: (m, n)."""
    least, most = e.mean - e.amplitude, e.mean + e.amplitude
    events = [e.load(cosine) for cosine in (e.cosine, np.cos(e.start + e.turn), -e.cosine, np.cos(e.start - e.turn))]
    corners = np.clip(np.broadcast_to(loads := corner_loads(contact), (len(loads), len(least))), e.permanent, most)
    loads = np.clip(np.stack([e.permanent, least, *events, *corners, most]), e.permanent, most)
    ends = contact.half_width(np.sort(loads, axis=0))
    few = len(corners) <= _FEW
    between = ends[:-1] + np.diff(ends, axis=0) * (_INSIDE if few else _INSIDE[_FEW_INSIDE])[:, None, None]
    kinks = contact.half_width(np.concatenate([loads[1:2], corners]) if few else loads[1:2])
    beside = np.minimum(kinks - ends[0], ends[-1] - kinks) * _BESIDE_KINK[:, None, None]
    points = [ends, *(part.reshape(-1, len(least)) for part in (between, kinks - beside, kinks + beside))]
    return np.sort(np.concatenate(points), axis=0).T


def _closer(density: Callable[[Indices, Array], Array], member: Indices, x: Array, w: Array, known: float) -> tuple[Array, Array]:
    """Three points each about maxima of W, and W there, (3, n), from wider ones: so close that W rises by a share `known` at most.

    Round by round a parabola through the three says where the next ones go. Where that does not take the bracket to half, they
    divide it evenly.
    """
    x, w = x.copy(), w.copy()
    left, poor = np.arange(len(member)), np.zeros(len(member), dtype=bool)
    for _ in range(_ROUNDS):
        left = left[_rise(x[:, left], w[:, left]) > known * np.abs(w[1, left])]
        if not len(left):
            break
        low, middle, high = x[:, left]
        length = high - low
        vertex = np.clip(_parabola(x[:, left], w[:, left])[1], low + 0.02 * length, high - 0.02 * length)
        step = np.clip(2 * np.abs(vertex - middle), 0.003 * length, 0.125 * length)
        near = np.abs(vertex - middle) < 0.1 * step
        centre = np.where(near, middle, vertex)
        before, after = np.maximum(centre - step, (low + centre) / 2), np.minimum(centre + step, (centre + high) / 2)
        # A vertex that is all but the middle point needs no work of its own: the third point goes beyond.
        third = np.where(near, (after + high) / 2, vertex)
        added = np.where(poor[left], low + length * _EVENLY[:, None], np.stack([before, third, after]))
        places = np.concatenate([x[:, left], added])
        works = np.concatenate([w[:, left], [density(member[left], row) for row in added]])
        order = np.argsort(places, axis=0, kind="stable")
        places, works = np.take_along_axis(places, order, 0), np.take_along_axis(works, order, 0)
        three = np.clip(np.argmax(works, axis=0), 1, len(works) - 2) + _THREE
        x[:, left], w[:, left] = np.take_along_axis(places, three, 0), np.take_along_axis(works, three, 0)
        poor[left] = x[2, left] - x[0, left] > length / 2
    return x, w


def _parabola(x: Array, w: Array) -> tuple[Array, Array]:
    """Value and place of the vertex of the parabola through three points, (3, n); the middle one where it bends up."""
    before, after = np.diff(x, axis=0)
    first, second = _slopes(x, w)
    bend = np.where(before + after > 0, second - first, 0.0) / np.where(before + after > 0, before + after, 1.0)
    slope = (first * after + second * before) / np.where(before + after > 0, before + after, 1.0)
    shift = np.where(bend < 0, slope / np.where(bend < 0, -2 * bend, 1.0), 0.0)
    return w[1] + slope * shift / 2, x[1] + shift


def _rise(x: Array, w: Array) -> Array:
    """How far a concave W may rise above w[1] between three points, (3, n): up to the chord of the other two, drawn on."""
    before, after = np.diff(x, axis=0)
    first, second = np.abs(_slopes(x, w))
    return np.maximum(first * after, second * before)


def _slopes(x: Array, w: Array) -> Array:
    """Slopes of the two chords of three points, (2, n); 0 for points that are one."""
    length = np.diff(x, axis=0)
    return np.diff(w, axis=0) / np.where(length > 0, length, np.inf)
