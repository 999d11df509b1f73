"""Steady ellipses of P and Q: their angles and loads, and permanent stick zone, W and W(x) of each on any profile.

# notation: P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase), r = Q1/f, A = 2/E*; u and v amplitudes of (Q -+ f P)/f;
#           E largest Q - f P, G least Q + f P, I least Q - f P, J slip front passes G, M = E a turn later;
#           P_T permanent stick load, P_c load at the slip front, c = a(P_c); P_x load at which a = |x|;
#           w = +-Q - f P, which grows in slip

Every angle and load difference comes from r, P1 and the phase without cancellation, however small the slip:

    u = |r exp(-i phase) - P1|,  v = |r exp(-i phase) + P1|,  P_T = P0 - (u + v)/2
    D = t_G - t_E = t_M - t_J = arg(P1^2 - r^2 + 2 i r P1 sin(phase)),  t_J - t_I = pi - D
    exp(-i t_E) = (r exp(-i phase) - P1)/u

    E-G  s = t - t_E:  rate f v sin(D - s),  P - P_c = u sin^2(s/2),         P_c - P_T = v sin^2((D - s)/2)
    I-J  s = t - t_I:  rate f u sin s,       P - P_c = 2 P1 sin t_E sin s
    J-M  s = t_M - t:  rate f u sin s,       P - P_c = v sin^2((D + s)/2),   P_c - P_T = u sin^2(s/2)

    W    = (f A/pi) int w' Lam(P, P_c) dt,                 Lam = int_{P_c}^P ln(a(eta)/c) d eta
    W(x) = (f A/pi) int p(x, P) w' arccosh(|x|/c) dt       over the times with c < |x| < a(P)

The forward part is that of I-M, the reverse part that of E-G. Each phase is cut at the angles at which P or P_c is the load P_b of
a corner of the profile:

    P = P_b    cos t = (P_b - P0)/P1:            E-G  t_E + s = t,     I-J  t_E + s = t +- pi,   J-M  t_E - s = +-t
    P_c = P_b  E-G  v sin^2((D - s)/2) = P_b - P_T,   J-M  u sin^2(s/2) = P_b - P_T,   I-J  t_E - s = t +- pi

W of many ellipses at once is one of two forms of a double integral over t and eta:

    W = (f A/pi) int w' Lam(P, P_c) dt        by one Gauss rule for each phase, where Lam is known in few passes over the nodes
    W = (2 f^2/(pi E*)) int M(P(a)) da/a      for any profile, M being the slip moment of the ellipse at the load eta = P(a):
    M(eta) = int (P - eta) w' dt/f            over the times with P_c < eta < P

since Lam = int (P - eta) d ln a(eta) over P_c < eta < P. M is elementary, and not smooth at six loads of the ellipse only; P(a)
needs no inverse but at those, and is smooth between the corners.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from semi_analytic.hertz import log_excess
from semi_analytic.profiles import Contact
from semi_analytic.quadrature import gauss, graded

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

PHASES = ("E-G", "I-J", "J-M")
# Pieces of phases and points at once: arrays of some megabytes.
_PIECES, _POINTS = 1024, 500
# A piece has converged where every second node alone changes this share of W, which leaves 2e-14 or less (10 times as much where
# P hardly grows), or after a few halvings this share of P0^2; it is halved so often at most.
_CONVERGED, _FEW, _NOTHING, _HALVINGS = 1e-9, 3, 1e-14, 15


@dataclass(frozen=True, eq=False)
class Ellipses:
    """Steady ellipses, turned the way round that has 0 <= phase <= pi; all arrays of shape (m,).

    Attributes
    ----------
    mean, amplitude : P0, P1
    u, v : amplitudes of (Q -+ f P)/f
    cosine, sine : of t_E
    turn : D
    permanent : P_T
    """

    mean: Array
    amplitude: Array
    u: Array
    v: Array
    cosine: Array
    sine: Array
    turn: Array
    permanent: Array

    def take(self, members: Any) -> Ellipses:
        """Some of them, in the shape of `members`."""
        return Ellipses(**{name: values[members] for name, values in vars(self).items()})

    def over(self, unit: Array) -> Ellipses:
        """The same with loads in units of their own, (m,)."""
        loads = {name: vars(self)[name] / unit for name in ("mean", "amplitude", "u", "v", "permanent")}
        return replace(self, **loads)

    @property
    def start(self) -> Array:
        """t_E in (0, pi]."""
        return np.arctan2(self.sine, self.cosine)

    @property
    def moving(self) -> NDArray[np.bool_]:
        """Whether P moves: an amplitude below 1e-200 of the mean moves no edge, and dividing by a subnormal one overflows."""
        return self.amplitude > 1e-200 * self.mean

    @property
    def deepest(self) -> Array:
        """Largest P - P_c: at the ends of E-G and J-M, or within I-J."""
        tangent = np.tan(self.turn / 2)
        square = tangent * tangent
        ends = np.maximum(self.u, self.v) * square / (1 + square)
        sine = np.where(tangent > 1, 2 * tangent / (1 + square), 1.0)
        return np.maximum(ends, 2 * self.amplitude * self.sine * sine)

    def load(self, cosine: Array | float) -> Array:
        """P where cos t is known, from the least load so that it keeps its digits close to full unloading."""
        return (self.mean - self.amplitude) + self.amplitude * (1 + cosine)


def ellipses_of(mean: Array, amplitude: Array, tangential: Array, phase: Array, friction: Array) -> Ellipses:
    """The geometry of the loops, the permanent stick load P_T among it; arrays (m,) of admissible values, friction > 0.

    >>> loop = ellipses_of(*(np.array([value]) for value in (3.0, 1.0, 0.5, math.pi / 2, 0.5)))  # P0, P1, Q1, phase, f
    >>> loop.permanent.round(12).tolist()  # u = v = sqrt 2: 3 - sqrt 2
    [1.585786437627]
    """
    p1, ratio = amplitude, tangential / friction
    # cos and sin of the phase from half of it; the mirrored loop, Q -> -Q, goes round the other way: phase + pi.
    half = np.tan(phase / 2)
    share = ratio / (1 + half * half)
    along, across = np.where(half < 0, -1.0, 1.0) * share * (1 - half) * (1 + half), 2 * share * np.abs(half)
    u, v = np.hypot(along - p1, across), np.hypot(along + p1, across)
    turn = np.arctan2(2 * p1 * across, (p1 - ratio) * (p1 + ratio))
    size = np.where(u > 0, u, 1.0)
    # P_T < 0 is admitted to rounding only: it is gross sliding.
    return Ellipses(mean, p1, u, v, (along - p1) / size, across / size, turn, np.maximum(mean - (u + v) / 2, 0.0))


def phase_of(name: str, e: Ellipses, s: Array) -> tuple[Array, Array, Array]:
    """Rate over f, P - P_c and P at angles s of a phase."""
    if name == "E-G":
        return e.v * np.sin(e.turn - s), e.u * np.sin(s / 2) ** 2, e.load(np.cos(e.start + s))
    sine = np.sin(s)
    if name == "I-J":
        return e.u * sine, 2 * e.amplitude * e.sine * sine, e.load(-np.cos(e.start + s))
    return e.u * sine, e.v * np.sin((e.turn + s) / 2) ** 2, e.load(np.cos(e.start - s))


def half_angle(part: Array) -> Array:
    """2 arcsin(sqrt(part)), of 0 below 0 and of 1 above 1."""
    return 2 * np.arcsin(np.sqrt(np.clip(part, 0.0, 1.0)))


def corner_angles(e: Ellipses, corners: Array) -> dict[str, Array]:
    """Ends of the pieces of each phase, ascending, (marks, m), for the loads of corners (c, 1)."""
    cosine = (corners - e.mean) / np.where(e.moving, e.amplitude, np.inf)
    above = np.maximum(corners - e.permanent, 0.0)
    # Corners that are not met, but nearly: a cut at the greatest or least load.
    high, low = np.arccos(np.clip(cosine, -1.0, 1.0)), np.arccos(np.clip(-cosine, -1.0, 1.0))
    by_v, by_u = (half_angle(above / np.where(size > 0, size, np.inf)) for size in (e.v, e.u))
    start, full = e.start, 2 * math.pi
    inside = {
        "E-G": (high - start, full - high - start, e.turn - by_v),
        "I-J": (low - start, full - low - start, start - low, start + low),
        "J-M": (start - high, start + high, by_u),
    }
    found = {}
    for name, length in zip(PHASES, (e.turn, math.pi - e.turn, e.turn), strict=True):
        rows = np.concatenate([np.zeros_like(start)[None], *inside[name], length[None]])
        found[name] = np.sort(np.clip(rows, rows[0], rows[-1]), axis=0)
    return found


def quadrature_error(values: Array, size: Array) -> Array:
    """Error over `size`, from above, of the first of three values: by one rule, by every second of its nodes, by every fourth.

    It is what the first two differ by, or if that falls like an exponential as it does where all is smooth, the power 1.5 of it
    (the power 2 would be just).
    """
    apart = (np.abs(values[k] - values[k + 1]) / np.where(size > 0, size, 1.0) for k in (0, 1))
    near, far = (np.minimum(each, 1e100) for each in apart)  # of slips of 1e-265 too
    return np.where(near <= far**1.5, near**1.5, near)


def works_over_time(e: Ellipses, contact: Contact) -> tuple[Array, Array]:
    """Forward and reverse part of W pi E*/(2 f^2), (m,) each, with all digits even where next to nothing slips: 1 ms and more each.

    The phases are cut at the corners; next to singular ends the rule is graded; pieces that have not converged are halved. NaN
    where that does not help.

    At constant P and Q between -k f P and k f P the sum is 2 P^2 [(1 - k) ln(1 - k) + k - k^2/2].

    >>> from semi_analytic.hertz import HertzContact
    >>> loop = ellipses_of(*(np.array([value]) for value in (1.0, 0.0, 0.3, math.pi / 2, 0.5)))  # k = 0.6
    >>> forward, reverse = works_over_time(loop, HertzContact(modulus=1.0, radius=1.0, datum_length=1.0))
    >>> round(float(forward[0] + reverse[0]), 12), round(2 * (0.4 * math.log(0.4) + 0.6 - 0.18), 12)
    (0.106967414501, 0.106967414501)
    """
    pieces = []
    for number, ends in enumerate(corner_angles(e, contact.break_loads[:, None]).values()):
        row, owner = np.nonzero((np.diff(ends, axis=0) > 1e-14 * ends[-1]) & (e.deepest > 0))
        pieces.append((np.full(len(row), number), owner, ends[row, owner], ends[row + 1, owner]))
    phase, member, begin, end = (np.concatenate(part) for part in zip(*pieces, strict=True))
    works, size = np.zeros((len(PHASES), len(e.mean))), np.zeros(len(e.mean))
    for level in range(_HALVINGS + 1):
        values = np.empty((2, len(member)))
        for number, name in enumerate(PHASES):
            those = np.flatnonzero(phase == number)
            for here in (those[k : k + _PIECES] for k in range(0, len(those), _PIECES)):
                s, weight = graded(begin[here], end[here])
                rate, slipped, load = phase_of(name, e.take(member[here, None]), s)
                terms = weight * rate * contact.dissipation_kernel(load, np.minimum(slipped, load))
                values[:, here] = [k * np.sum(terms[:, ::k], axis=1) for k in (1, 2)]
        size = size if level else np.asarray(np.bincount(member, values[0], len(size)), dtype=float)
        error = np.abs(values[0] - values[1])
        done = ~(error > _CONVERGED * size[member]) | ((level >= _FEW) & (error <= _NOTHING * np.square(e.mean[member])))
        np.add.at(works, (phase[done], member[done]), values[0, done])
        phase, member, begin, end = (part[~done] for part in (phase, member, begin, end))
        middle = (begin + end) / 2
        phase, member, begin, end = np.tile(phase, 2), np.tile(member, 2), np.r_[begin, middle], np.r_[middle, end]
        if not len(member):
            break
    works[phase, member] = np.nan
    return works[1] + works[2], works[0]


def density_of(e: Ellipses, contact: Contact, x: Array, every: int = 1) -> tuple[Array, Array]:
    """Forward and reverse part of W(x) pi E*/(2 f^2), arrays (m,): member k at |x| = x[k].

    With `every` = 2 by every second node of the rule, to some 1e-6.
    """
    works = np.zeros((len(PHASES), len(x)))
    for first in range(0, len(x), _POINTS):
        here = np.arange(first, min(first + _POINTS, len(x)))
        works[:, here] = _densities(e.take(here[:, None]), contact, x[here, None], every)
    return works[1] + works[2], works[0]


def _densities(e: Ellipses, contact: Contact, x: Array, every: int) -> Array:
    """W(x) of each phase, (3, m), for x (m, 1), all at once.

    The point is in contact for pi + h < t < 3 pi - h, h being half the angle about the least load within which it is open,
    2 P1 sin^2(h/2) = P_x - P_min. The front passes it in E-G where sin^2((D - s)/2) = (P_x - P_T)/v, in I-J at s = t_E - h, in J-M
    where sin^2(s/2) = (P_x - P_T)/u.
    """
    edge = contact.load(x)
    share = (edge - e.mean + e.amplitude) / np.where(e.moving, 2 * e.amplitude, 1.0)
    away = half_angle(np.where(e.moving, share, np.where(edge > e.mean, 1.0, 0.0)))
    above, start, turn = np.maximum(edge - e.permanent, 0.0), e.start, e.turn
    by_v, by_u = (half_angle(above / np.where(size > 0, size, np.inf)) for size in (e.v, e.u))
    first = np.maximum(turn - by_v, 0.0)
    ranges = (
        (0, first, np.minimum(turn, math.pi - away - start)),
        (0, np.maximum(first, math.pi + away - start), turn),
        (1, np.abs(start - away), np.minimum(math.pi - turn, 2 * math.pi - away - start)),
        (2, np.maximum(0.0, start - math.pi + away), np.minimum(np.minimum(turn, by_u), start + math.pi - away)),
    )
    marks = list(corner_angles(e.take((slice(None), 0)), contact.break_loads[:, None]).values())
    total = np.zeros((len(PHASES), len(x)))
    for number, begin, end in ranges:
        cuts = np.concatenate([begin, np.clip(marks[number].T, begin, np.maximum(begin, end)), end], axis=1)
        member, piece = np.nonzero(cuts[:, 1:] > cuts[:, :-1])
        if len(member):
            s, weight = graded(cuts[member, piece], cuts[member, piece + 1], every)
            growth, slipped, load = phase_of(PHASES[number], e.take(member), s)
            front = np.maximum(load - slipped, 0.0)
            ratio = contact.arccosh_ratio(x[member], np.maximum(edge[member] - front, 0.0), contact.advance(front))
            np.add.at(total[number], member, np.sum(weight * growth * contact.pressure(x[member], load) * ratio, axis=1))
    return total


Area = Callable[[Array, Array, Array], Array]
"""Some multiple of Lam(P, P_c) from P_c, P - P_c and a free array, (phases, n, m) each; may overwrite all but the second."""

_TINY, _FLOOR = 1e-100, 1e-200

# ------------------------------------------------------------------------------------------- any profile, over the contact
# Nodes and pieces at once, in arrays that fit into the cache.
_ELEMENTS = 32768
# A piece has converged at this share of W, of a share of P0^2 where W is less: 1e-12 of P0^2 is left. Its nodes are doubled up
# to so many.
_SETTLED, _NO_WORK, _MOST_NODES = 1e-11, 1e-3, 4096
# Share of P0 below which P - P_c would not keep ten digits as a difference of loads.
_SHALLOW = 1e-5


def dissipation_of(e: Ellipses, contact: Contact) -> Array:
    """Forward and reverse part of W pi E*/(2 f^2) on any profile, (2, m); NaN where the quadrature does not converge.

    To ten digits; over time where a difference of loads would not leave P - P_c as many.

    Between two of the half-widths at which M or P(a) is not smooth by Fejer's rule in t, a being the step 3 t^2 - 2 t^3, in which
    roots at both ends are smooth, with 15 nodes, 31, 63, ...; the rules of every second node show the error.

    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.steady_ellipse import ellipses_of
    >>> loop = ellipses_of(*(np.array([value]) for value in (1.0, 0.0, 0.3, math.pi / 2, 0.5)))  # constant P, Q1 = 0.6 f P
    >>> works = dissipation_of(loop, HertzContact(modulus=1.0, radius=1.0, datum_length=1.0))
    >>> round(float(works.sum()), 9), round(2 * (0.4 * math.log(0.4) + 0.6 - 0.18), 9)  # theory, constant load
    (0.106967415, 0.106967415)
    """
    # Half-widths by how far they are beyond that of no load: beside a flat the rest has no digits.
    corners = np.array(contact.breaks, dtype=float)[:, None] - contact.least
    chunk = max(_ELEMENTS // (16 * (5 + len(corners))), 8)
    if len(e.mean) > chunk:
        parts = [e.take(slice(first, first + chunk)) for first in range(0, len(e.mean), chunk)]
        return np.concatenate([dissipation_of(part, contact) for part in parts], axis=1)
    loads = [e.permanent, *(e.load(cosine) for cosine in (-1.0, e.cosine, -e.cosine, np.cos(e.start + e.turn), 1.0))]
    events = contact.advance(np.clip(loads, loads[0], loads[-1]))
    ends = np.sort(np.concatenate([events, np.clip(corners, events[0], events[-1])]), axis=0)
    row, member = np.nonzero(np.diff(ends, axis=0) > 1e-15 * ends[-1])
    low, high, loops = ends[row, member], ends[row + 1, member], e.take(member)
    # NaN already where a half-width was not found.
    works, size = np.zeros((2, 1)) * np.sum(events, axis=0), np.zeros(len(e.mean))
    known, count = np.empty((2, 0, len(member))), 16
    while len(member):
        t = _fejer(count)[0][:: 1 if count == 16 else 2, None]
        share = np.minimum(t, 1 - t) ** 2 * (1 + 2 * np.maximum(t, 1 - t))
        advance = np.where(t < 0.5, low + (high - low) * share, high - (high - low) * share)
        terms = slip_moment(loops, np.maximum(contact.load_at(advance) - loops.permanent, 0.0))
        terms *= (high - low) / (contact.least + advance) * (6 * t * (1 - t))
        if count > 16:
            terms = np.stack([terms, np.append(known, terms[:, :1], axis=1)], axis=2).reshape(2, -1, len(member))[:, :-1]
        rules = np.stack([_fejer(count // k)[1] @ terms[:, k - 1 :: k] for k in (1, 2, 4)])
        if count == 16:
            size = np.maximum(np.bincount(member, np.sum(rules[0], axis=0), len(size)), _NO_WORK * np.square(e.mean))
        whole, scale = np.sum(rules, axis=1), size[member]
        # Two rules may agree by chance: the one before them must be as near as such a fall leaves it.
        left = (quadrature_error(whole, scale) > _SETTLED) | (np.abs(whole[1] - whole[2]) ** 3 > _SETTLED * scale**3)
        for direction in range(2):
            np.add.at(works[direction], member[~left], rules[0, direction, ~left])
        member, low, high, loops, known = member[left], low[left], high[left], loops.take(left), terms[..., left]
        if count == _MOST_NODES:
            works[:, member] = np.nan
            break
        count *= 2
    shallow = np.flatnonzero(e.deepest <= _SHALLOW * e.mean)
    if len(shallow):
        exact = np.array(works_over_time(e.take(shallow), contact))
        # What is known to a share of P0^2 only is better than nothing.
        works[:, shallow] = np.where(np.isfinite(exact), exact, works[:, shallow])
    return works


@cache
def _fejer(count: int) -> tuple[Array, Array]:
    """Nodes and weights of Fejer's second rule on [0, 1], (count - 1,) each; every second node is one of half the count."""
    angle, order = math.pi * np.arange(1, count) / count, np.arange(1, count // 2 + 1)
    terms = np.where(2 * order == count, 1.0, 2.0) / (4.0 * order**2 - 1) * np.cos(2 * np.outer(angle, order))
    return np.square(np.sin(angle / 2)), (1 - np.sum(terms, axis=1)) / count


def slip_moment(e: Ellipses, above: Array) -> Array:
    """M(eta) of forward and of reverse slip, (2, n, m), at eta = P_T + `above`, (n, m).

    With s = t - t_I forward slip has the rate f u sin s and P = P0 - P1 cos(t_E + s), reverse slip with s = t_G - t the rate
    f v sin s and P = P0 + P1 cos(t_G - s). P_c < eta < P holds from where the front passes eta, or P does, to where P does again;
    in reverse but for the times about the least load at which P < eta, |t - pi| < h with P0 - eta = P1 cos h.
    """
    start, end = e.start, e.start + e.turn
    drop = (e.u + e.v) / 2 - above  # P0 - eta
    open_half = half_angle((e.amplitude - drop) / (2 * np.maximum(e.amplitude, _FLOOR * e.mean)))
    by_u, by_v = (half_angle(above / np.maximum(size, _FLOOR * e.mean)) for size in (e.u, e.v))
    drop *= 2
    begin = np.where(by_u < e.turn, math.pi - by_u, np.abs(start - open_half))
    forward = _moment(begin, np.maximum(np.minimum(2 * math.pi - open_half - start, math.pi), begin), drop, e.sine, -e.cosine, e)
    top, middle = np.minimum(by_v, e.turn), end - math.pi
    sine, cosine = np.sin(end), np.cos(end)
    reverse = _moment(np.minimum(np.maximum(middle + open_half, 0.0), top), top, drop, sine, cosine, e)
    first = np.minimum(middle - open_half, top)
    early = np.flatnonzero(np.any(first > 0, axis=0))
    if len(early):
        begin = np.zeros(1)
        some = (np.maximum(first[:, early], 0.0), drop[:, early], sine[early], cosine[early], e.take(early))
        reverse[:, early] += _moment(begin, *some)
    return np.stack([e.u * forward, e.v * reverse])


def _moment(begin: Array, end: Array, twice: Array, sine: Array, cosine: Array, e: Ellipses) -> Array:
    """int sin s (P0 - eta + P1 cos(s - psi)) ds from begin to end, from 2 (P0 - eta) and P1's part sin psi, cos psi.

    = 2 (P0 - eta) sin m sin d + P1 [sin(2 m - psi) sin d cos d + d sin psi], m the middle and d half the range.
    """
    half, middle = (end - begin) / 2, (end + begin) / 2
    # One tangent for sine and cosine: numpy has it in vector code.
    tangent = np.tan(half / 2)
    over = 1 / (1 + tangent * tangent)
    sine_half, cosine_half = 2 * tangent * over, 2 * over - 1
    tangent = np.tan(middle / 2)
    over = 1 / (1 + tangent * tangent)
    sine_middle, cosine_middle = 2 * tangent * over, 2 * over - 1
    double = (2 * e.amplitude * cosine) * sine_middle * cosine_middle
    double += (e.amplitude * sine) * (2 * sine_middle * sine_middle - 1)
    return sine_half * (twice * sine_middle + cosine_half * double) + (e.amplitude * sine) * half


# ------------------------------------------------------------------- Hertz, power laws, flat and rounded faces: by Lam
# Nodes of one phase at once: arrays that fit into the cache.
_NODES = 16384
# Gauss rules on [0, 1], symmetric about the middle; the last one for singularities at the ends.
_COUNTS = (12, 14, 16, 18, 20, 23, 26, 32, 42)
_RULES = (*(gauss(count) for count in _COUNTS), graded(0.0, 1.0))
_LEAST_SUMS = np.cosh(30.0 / (2 * np.array(_COUNTS)))[:, None]


def works_by_lam(e: Ellipses, quick: Area, careful: Area, deep: float) -> tuple[Array, Array]:
    """Forward and reverse part of W pi E*/(2 f^2), (m,), over what the areas are of Lam: each member by as many nodes as it needs.

    `quick` is right to rounding of P - P_c and serves where that reaches a share `deep` of P0; `careful` to rounding of itself.
    """
    # Where u is next to nothing, as at tangency, a phase with no slip to speak of would add rounding times v.
    unlike = np.minimum(e.u, e.v) <= deep * np.maximum(e.u, e.v)
    # Members alike together: the same rule, and the same way to Lam.
    kind = 2 * _rule_of(e) + ((e.deepest <= deep * e.mean) | unlike)
    order = np.argsort(kind, kind="stable")
    loops, found = _rows(e).take(order, axis=1), np.empty((3, len(order)))
    bounds = np.cumsum(np.bincount(kind, minlength=2 * len(_RULES)))
    # Used again and again: what is allocated once stays in the cache.
    memory = np.empty(12 * max(_NODES, 64 * len(_RULES[-1][0])))
    for number in np.flatnonzero(np.diff(bounds, prepend=0)).tolist():
        step = max(_NODES // len(_RULES[number // 2][0]), 64)
        for begin in range(bounds[number - 1] if number else 0, bounds[number], step):
            here = slice(begin, min(begin + step, bounds[number]))
            found[:, order[here]] = phase_integrals(loops[:, here], _RULES[number // 2], (quick, careful)[number % 2], memory)
    reverse, later, early = 2 * found
    k = 4 * e.amplitude * e.sine
    early *= (math.pi - e.turn) * e.u / np.where(k > _FLOOR * e.mean, k, np.inf)
    return later * e.turn * e.u + early, reverse * e.turn * e.v


def _rule_of(e: Ellipses) -> NDArray[np.uint8]:
    """Index in `_RULES` of the least rule that leaves exp(-30), (m,), from where the integrands stop being analytic.

    In J-M and E-G the logarithm is singular where P_c = 0, at s = +-2 i arsinh(sqrt(P_T/u)) from M, and with v from G. Where P = 0
    it is so +-2 i arsinh(sqrt(P_min/(2 P1))) beside t = pi, at s = pi - t_E in E-G and s = t_E in I-J; the mirror images in J-M and
    of I-J are farther away. Gauss' rule of n nodes leaves about rho^(-2 n), rho + 1/rho being the sum of the distances of the
    nearest singularity from the ends of the interval [-1, 1]. Twelve at least, since nearly without slip the integrand is a cube
    of sines.
    """
    start, wide, rest = e.start, np.maximum(e.turn, _TINY), np.maximum(math.pi - e.turn, _TINY)
    front, load = (
        np.square(4 * np.arcsinh(np.sqrt(level / np.maximum(size, _TINY))))
        for level, size in ((e.permanent, np.maximum(e.u, e.v)), (e.mean - e.amplitude, 2 * e.amplitude))
    )
    half_sum = np.full(len(wide), np.inf)
    for centre, square in (
        (-1.0, front / (wide * wide)),
        (2 * (math.pi - start) / wide - 1, load / (wide * wide)),
        (2 * start / rest - 1, load / (rest * rest)),
    ):
        near, far = (np.sqrt(np.square(centre + side) + square) for side in (-1, 1))
        np.minimum(half_sum, (near + far) / 2, out=half_sum)
    return np.sum(half_sum < _LEAST_SUMS, axis=0, dtype=np.uint8)


def _rows(e: Ellipses) -> Array:
    """What `phase_integrals` takes, (9, m): h, g, P_T, P_min, u, v, alpha, beta, k."""
    rows = np.empty((9, len(e.mean)))
    rows[0], rows[1] = e.turn / 2, (math.pi - e.turn) / 2
    # A permanent or least load of 0 as the smallest load there is: the logarithm of 0 is never asked for.
    np.maximum(e.permanent, _FLOOR * e.mean, out=rows[2])
    np.maximum(e.mean - e.amplitude, _FLOOR * e.mean, out=rows[3])
    rows[4], rows[5] = e.u, e.v
    larger = np.sqrt(e.amplitude * (1 + np.abs(e.cosine)))
    smaller = e.amplitude * e.sine / np.where(larger > 0, larger, 1.0)
    before = e.cosine < 0
    rows[6], rows[7] = np.where(before, larger, smaller), np.where(before, smaller, larger)
    rows[8] = 4 * e.amplitude * e.sine
    return rows


def phase_integrals(loops: Array, rule: tuple[Array, Array], area: Area, memory: Array) -> tuple[Array, Array, Array]:
    """Sums by the rule of `area` times S C in E-G and J-M, times P - P_c in I-J; `loops` (9, m) are rows h to k. Arrays (m,).

    # notation: h = D/2, g = (pi - D)/2, y node of [0, 1], nodes along axis 0, members along axis 1;
    #           alpha = sqrt(2 P1) sin(t_E/2), beta = sqrt(2 P1) cos(t_E/2), k = 4 alpha beta = 4 P1 sin(t_E)

    With S = sin(h y), C = cos(h y) at the nodes and a bar for the node 1 - y, which is one of the same rule:

        E-G  s = D (1 - y)    rate 2 f v S C       P_c = P_T + v S^2                    P - P_c = u S-bar^2
        J-M  s = D y          rate 2 f u S C       P_c = P_T + u S^2                    P - P_c = v S-bar^2 + k S C
        I-J  s = 2 g y        rate 2 f u s c       P_c = P_min + (alpha c - beta s)^2   P - P_c = k s c,   s, c = sin, cos (g y)

    No difference is taken but one that is squared. One tangent a node stands for sine and cosine: numpy has it in vector code.
    """
    (nodes, weights), (half, rest, permanent, least, u, v, alpha, beta, k) = rule, loops
    shape = (4, 3, len(nodes), len(half))
    front, slipped, (tangent, both, spare), free = memory[: math.prod(shape)].reshape(shape)
    np.multiply(nodes[:, None], half, out=tangent)
    np.tan(tangent, out=tangent)
    np.multiply(tangent, tangent, out=spare)
    spare += 1
    np.divide(tangent, spare, out=both)
    tangent *= both  # S^2
    np.multiply(tangent, v, out=front[0])
    np.multiply(tangent, u, out=front[1])
    slipped[0] = front[1][::-1]
    np.multiply(both, k, out=slipped[1])
    slipped[1] += front[0][::-1]
    front[:2] += permanent
    np.multiply(nodes[:, None], rest, out=tangent)
    np.tan(tangent, out=tangent)
    np.multiply(tangent, tangent, out=spare)
    spare += 1
    np.divide(tangent, spare, out=slipped[2])
    slipped[2] *= k
    tangent *= beta
    np.subtract(alpha, tangent, out=tangent)
    tangent *= tangent
    np.divide(tangent, spare, out=front[2])
    front[2] += least
    areas = area(front, slipped, free)
    areas[:2] *= both
    areas[2] *= slipped[2]
    return weights @ areas[0], weights @ areas[1], weights @ areas[2]


def quick_bracket(front: Array, slipped: Array, free: Array) -> Array:
    """P ln(P/P_c) - P + P_c, to rounding of P - P_c: n Lam of the power law |x|^n, 2 Lam of Hertz."""
    np.divide(slipped, front, out=free)
    np.log1p(free, out=free)
    front += slipped
    free *= front
    free -= slipped
    return free


def careful_bracket(front: Array, slipped: Array, free: Array) -> Array:
    """The same to rounding of itself."""
    del free
    front += slipped
    return front * log_excess(slipped / front)


_CELL_BITS = 4
_CELLS = 1 << _CELL_BITS
_REST, _ONE = np.int64((1 << (52 - _CELL_BITS)) - 1), np.int64(1023 << 52)
# Of the Chebyshev series through twelve points eight terms leave 1e-16; as powers of half its argument.
_PLACES, _TERMS = np.cos(math.pi * (np.arange(12) + 0.5) / 12), 8
_SERIES = [np.pad(chebyshev.cheb2poly(row[: k + 1]), (0, _TERMS - 1 - k)) for k, row in enumerate(np.eye(_TERMS))]
_TO_POWERS = 2.0 ** np.arange(_TERMS)[:, None] * (np.transpose(_SERIES) @ np.linalg.inv(chebyshev.chebvander(_PLACES, 11))[:_TERMS])
_NEAR_RULE = tuple((float(node), float(weight * (1 - node))) for node, weight in zip(*gauss(7), strict=True))


class LamTable:
    """Lam of a flat and rounded face, between two loads: polynomials in P on sixteen cells of every octave.

        Lam(P, P_c) = J(P) - J(P_c) - (P - P_c) L(P_c),     J = int_0^P L d eta, L = ln a = dJ/dP
        where P_c is close to P:  (P - P_c)^2 int_0^1 (1 - z) L'(P_c + z (P - P_c)) dz

    The number of a cell is that of the leading bits of the load, so that there is no search. To 1e-13.
    """

    def __init__(self, contact: Contact, first: int, last: int) -> None:
        """From 2^first to 2^(last + 1)."""
        self._first = (1023 + first) << _CELL_BITS
        octave, cell = (grid.ravel() for grid in np.mgrid[first : last + 1, :_CELLS])
        load = np.ldexp(1 + (cell[:, None] + (1 + _PLACES) / 2) / _CELLS, octave[:, None])
        contact = replace(contact, datum_length=contact.least / 2)  # L = ln(a/b) keeps its digits beside the flat
        area, log = -contact.log_distance(load), -contact.log_ratio(load)
        # Of a short way about the load Lam is half of its square times L', but for a share of 3e-14.
        way = 1e-6 * load
        with np.errstate(all="ignore"):
            rate = 2 * contact.dissipation_kernel(load + way * (2 / 3), way) / (way * way)
        self._area, self._log, self._rate = (_TO_POWERS @ values.T for values in (area, log, rate))

    def _place(self, load: Array) -> tuple[NDArray[np.int64], Array]:
        """Cells of loads, and places in them from -1/2 to 1/2."""
        bits = load.view(np.int64)
        inside = bits & _REST
        inside <<= _CELL_BITS
        inside |= _ONE
        cell = bits >> (52 - _CELL_BITS)
        cell -= self._first
        return cell, inside.view(np.float64) - 1.5

    def quick(self, front: Array, slipped: Array, free: Array) -> Array:
        """Lam from P_c and P - P_c, (phases, n, m), to some 1e-16 of P^2 over P - P_c."""
        for below, way, area in zip(front, slipped, free, strict=True):  # one phase after the other: it stays in the cache
            cell, inside = self._place(np.stack([below + way, below]))
            upper, lower = _series(self._area, cell, inside)
            upper -= lower
            np.multiply(way, _series(self._log, cell[1], inside[1]), out=area)
            np.subtract(upper, area, out=area)
        return free

    def careful(self, front: Array, slipped: Array, free: Array) -> Array:
        """The same to 1e-13 of itself."""
        near = np.zeros(front.shape)
        for node, weight in _NEAR_RULE:
            near += weight * _series(self._rate, *self._place(front + node * slipped))
        return np.where(0.7 * slipped < 0.3 * front, near * slipped * slipped, self.quick(front, slipped, free))


def _series(rows: Array, cell: NDArray[np.int64], inside: Array) -> Array:
    """Polynomials, rows from the lowest power on, columns for the cells; beyond the ends those of the first or last cell."""
    total, row = rows[-1].take(cell, mode="clip"), np.empty(cell.shape)
    for coefficients in rows[-2::-1]:
        total *= inside
        total += coefficients.take(cell, mode="clip", out=row)
    return total
