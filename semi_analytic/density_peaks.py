"""The maxima of the pointwise dissipation W(x) of steady ellipses; letters and angles of `steady_ellipse`.

Where slip goes on at the least load, W has a kink at a(P_min). With d the distance from it, W goes as d ln|d|: the slope is minus
infinity on both sides. A first maximum, the shoulder, may therefore lie just inside a(P_min) and a second one further out. At the
corners of a profile W may have a kink too. At the edges of contact at E and G it has two derivatives (it goes as d^(5/2)), at those
of I and J more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from semi_analytic.profiles import Contact
from semi_analytic.roundoff import LAST_DIGITS, PROMISED
from semi_analytic.steady_ellipse import Ellipses, density_of, quadrature_error

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

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


def maxima_of(e: Ellipses, contact: Contact) -> Array:
    """The two largest maxima of W(x) of each member, (6, m).

    Rows: the largest W(x) pi E*/(2 f^2), the second largest, the error of the largest, their |x|, and that of the largest as a
    fraction, 0 at the permanent stick edge, 1 at the largest contact. The largest is 0 and the rest NaN where nothing slips; the
    second one is NaN where there is one maximum only.

    In each piece between kinks and events W is sampled; the maximum is looked for about every sample above its neighbours.
    """
    if len(e.mean) > _MEMBERS:
        parts = [e.take(slice(first, first + _MEMBERS)) for first in range(0, len(e.mean), _MEMBERS)]
        return np.concatenate([maxima_of(part, contact) for part in parts], axis=1)

    def density(member: Indices, x: Array, every: int = 1) -> Array:
        forward, reverse = density_of(e.take(member), contact, x, every)
        return forward + reverse

    points, count = _samples(e, contact), len(e.mean)
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
    top, at, rise = _parabola(near, works)
    order, best = np.argsort(top, kind="stable"), np.full(count, -1)
    best[owner[order]] = order
    # Where d = P - P_c is small the last digits of P_x count for more. W(x) that is lost in them is at most the product of p,
    # 2 (u + v) and arccosh(|x|/c), which is 2 (u + v) d/(pi a).
    deepest, safe = e.deepest, np.where(e.deepest > 0, e.deepest, np.inf)
    relative = PROMISED + 3 * LAST_DIGITS * (e.mean + e.amplitude) / safe
    least = 2 / math.pi * (e.u + e.v) * deepest / np.where(inner > 0, inner, outer)
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
    fraction = (place - inner) / np.where(outer > inner, outer - inner, 1.0)
    return np.stack([value, second_value, error, place, second_place, fraction])


def _samples(e: Ellipses, contact: Contact) -> Array:
    """Points from the permanent stick edge to the largest contact, ascending, some of them equal: (m, n)."""
    least, most = e.mean - e.amplitude, e.mean + e.amplitude
    events = [e.load(cosine) for cosine in (e.cosine, np.cos(e.start + e.turn), -e.cosine, np.cos(e.start - e.turn))]
    corners = np.clip(contact.break_loads[:, None], e.permanent, most)
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
        left = left[_parabola(x[:, left], w[:, left])[2] > known * np.abs(w[1, left])]
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


def _parabola(x: Array, w: Array) -> tuple[Array, Array, Array]:
    """Of three points, (3, n): value and place of the vertex of the parabola through them, the middle one where it bends up; how
    far a concave W may rise above w[1] between them, which is up to the chord of the other two, drawn on.
    """
    before, after = length = np.diff(x, axis=0)
    first, second = np.diff(w, axis=0) / np.where(length > 0, length, np.inf)
    whole = np.where(before + after > 0, before + after, np.inf)
    bend, slope = (second - first) / whole, (first * after + second * before) / whole
    shift = np.where(bend < 0, slope / np.where(bend < 0, -2 * bend, 1.0), 0.0)
    return w[1] + slope * shift / 2, x[1] + shift, np.maximum(np.abs(first) * after, np.abs(second) * before)
