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
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semi_analytic.profiles import Contact
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

PHASES = ("E-G", "I-J", "J-M")
# Pieces of phases and points at once: arrays of some megabytes.
_PIECES, _POINTS = 1024, 500
# A piece has converged at this share of W, or after a few halvings at this share of P0^2; it is halved so often at most.
_CONVERGED, _FEW, _NOTHING, _HALVINGS = 1e-10, 3, 1e-14, 15


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
        values = np.empty((3, len(member)))
        for number, name in enumerate(PHASES):
            those = np.flatnonzero(phase == number)
            for here in (those[k : k + _PIECES] for k in range(0, len(those), _PIECES)):
                s, weight = graded(begin[here], end[here])
                rate, slipped, load = phase_of(name, e.take(member[here, None]), s)
                terms = weight * rate * contact.dissipation_kernel(load, np.minimum(slipped, load))
                values[:, here] = [2**k * np.sum(terms[:, :: 2**k], axis=1) for k in range(3)]
        size = size if level else np.asarray(np.bincount(member, values[0], len(size)), dtype=float)
        error = quadrature_error(values, size[member])
        done = ~(error > _CONVERGED) | ((level >= _FEW) & (error * size[member] <= _NOTHING * np.square(e.mean[member])))
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
