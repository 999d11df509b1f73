"""Dissipation of many steady ellipses in one call.

# notation: P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase), r = Q1/f, A = 2/E*; u and v amplitudes of (Q -+ f P)/f;
#           E largest Q - f P, G least Q + f P, I least Q - f P, J front passes G, M = E a turn later; P_T permanent stick load

Every angle and load difference comes from r, P1 and the phase without cancellation, however small the slip:

    u = |r exp(-i phase) - P1|,  v = |r exp(-i phase) + P1|,  P_T = P0 - (u + v)/2
    D = t_G - t_E = t_M - t_J = arg(P1^2 - r^2 + 2 i r P1 sin(phase)),  t_J - t_I = pi - D
    exp(-i t_E) = (r exp(-i phase) - P1)/u

    E-G  s = t - t_E:  rate f v sin(D - s),  P - P_c = u sin^2(s/2),         P_c - P_T = v sin^2((D - s)/2)
    I-J  s = t - t_I:  rate f u sin s,       P - P_c = 2 P1 sin t_E sin s
    J-M  s = t_M - t:  rate f u sin s,       P - P_c = v sin^2((D + s)/2),   P_c - P_T = u sin^2(s/2)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semi_analytic.contact import Contact
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]

_CHUNK = 1000
_DEEP = 0.05
_DIGITS = 30.0


def _gauss(count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (1 + nodes) / 2, weights / 2


_RULES: tuple[tuple[Array, Array], ...] = (*(_gauss(count) for count in (12, 16, 22, 30, 42)), graded(0.0, 1.0))


class Reason(IntEnum):
    """Why a member of a batch has no value."""

    NONE = 0
    SLIDING = 1
    SEPARATION = 2
    INVALID = 3


@dataclass(frozen=True, eq=False)
class Ellipses:
    """Steady ellipses, turned the way round that has 0 <= phase <= pi; all arrays of shape (m, 1).

    Attributes
    ----------
    mean, amplitude, ratio, friction : P0, P1, r = Q1/f, f
    u, v : amplitudes of (Q -+ f P)/f
    cosine, sine : of t_E
    turn : D
    permanent : P_T
    """

    mean: Array
    amplitude: Array
    ratio: Array
    friction: Array
    u: Array
    v: Array
    cosine: Array
    sine: Array
    turn: Array
    permanent: Array

    def take(self, members: Any) -> Ellipses:
        """Some of them."""
        return Ellipses(**{name: values[members] for name, values in vars(self).items()})

    @property
    def start(self) -> Array:
        """t_E in (0, pi]."""
        return np.arctan2(self.sine, self.cosine)

    def load(self, cosine: Array) -> Array:
        """P where cos t is known, from the least load so that it keeps its digits close to full unloading."""
        return (self.mean - self.amplitude) + self.amplitude * (1 + cosine)


def ellipses_of(mean: Array, amplitude: Array, tangential: Array, phase: Array, friction: Array) -> Ellipses:
    """The geometry of the loops; arrays (m,) of admissible values, friction > 0."""
    p0, p1, f = (values[:, None] for values in (mean, amplitude, friction))
    ratio, angle = tangential[:, None] / f, phase[:, None]
    along, across = ratio * np.cos(angle), ratio * np.abs(np.sin(angle))
    # The mirrored loop, Q -> -Q, goes round the other way: phase + pi.
    along = np.where(np.sin(angle) < 0, -along, along)
    u, v = np.hypot(along - p1, across), np.hypot(along + p1, across)
    turn = np.arctan2(2 * p1 * across, (p1 - ratio) * (p1 + ratio))
    size = np.where(u > 0, u, 1.0)
    return Ellipses(p0, p1, ratio, f, u, v, (along - p1) / size, across / size, turn, p0 - (u + v) / 2)


def reasons(mean: Array, amplitude: Array, mean_force: Array, tangential: Array, phase: Array, friction: Array) -> NDArray[np.int8]:
    """Reason of each member (m,): negative or not finite values, separation, gross sliding. |Q| = f P is admitted, to rounding."""
    values = np.array([mean, amplitude, mean_force, tangential, phase, friction])
    invalid = ~np.all(np.isfinite(values), axis=0) | (mean <= 0) | (amplitude < 0) | (tangential < 0) | (friction < 0)
    along, across = tangential * np.cos(phase), tangential * np.sin(phase)
    slack = 4e-16 * (np.abs(mean_force) + tangential + friction * (mean + amplitude))
    limit = friction * mean
    forward = mean_force + np.hypot(along - friction * amplitude, across) > limit + slack
    reverse = np.hypot(along + friction * amplitude, across) - mean_force > limit + slack
    code = np.where(amplitude > mean, Reason.SEPARATION, np.where(forward | reverse, Reason.SLIDING, Reason.NONE))
    return np.where(invalid, Reason.INVALID, code).astype(np.int8)


def broadcast(*values: ArrayLike) -> tuple[tuple[int, ...], list[Array]]:
    """Common shape, and each as a flat array."""
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in values))
    return arrays[0].shape, [np.ascontiguousarray(array).reshape(-1) for array in arrays]


def dissipation_of(ellipses: Ellipses, contact: Contact) -> tuple[Array, Array]:
    """Forward and reverse part of W pi/(2 f^2) E*, arrays (m,): each member by as many Gauss points as it needs, in chunks."""
    count = len(ellipses.mean)
    forward, reverse = np.empty(count), np.empty(count)
    tiers = _tiers(ellipses)
    depth = _deep(ellipses)
    for number, rule in enumerate(_RULES):
        members = np.flatnonzero(tiers == number)
        # Those that hardly slip together: they need what the others can do without.
        members = members[np.argsort(depth[members], kind="stable")]
        for first in range(0, len(members), _CHUNK):
            here = members[first : first + _CHUNK]
            forward[here], reverse[here] = _works(ellipses.take(here), contact_for(contact, here, count), *rule)
    return forward, reverse


def contact_for(contact: Contact, members: NDArray[np.intp], count: int) -> Contact:
    """The contact of some members: its parameters are numbers, or arrays (count, 1)."""
    changes = {
        item.name: getattr(contact, item.name)[members]
        for item in fields(contact)  # type: ignore[arg-type]
        if np.shape(getattr(contact, item.name)) == (count, 1)
    }
    return replace(contact, **changes) if changes else contact  # type: ignore[type-var]


def _tiers(ellipses: Ellipses) -> NDArray[np.intp]:
    """Index of the least rule that is enough: by the ellipses about the intervals within which the integrands are analytic.

    In J-M and E-G the logarithm is singular where P_c = 0, at s = +-2 i arsinh(sqrt(P_T/u)) from M, and with v from G; where P = 0
    it is so at t = pi and 3 pi +- 2 i arsinh(sqrt(P_min/(2 P1))), and in I-J at their mirror images in I.
    """
    e = ellipses
    with np.errstate(divide="ignore", over="ignore"):
        front = np.minimum(_bernstein(0.0, e.permanent / e.u, e.turn), _bernstein(0.0, e.permanent / e.v, e.turn))
        least = (e.mean - e.amplitude) / (2 * e.amplitude)
        rest = math.pi - e.turn
        marks = ((math.pi - e.start, e.turn), (e.start - math.pi, e.turn), (e.start, rest), (2 * math.pi - e.start, rest))
        load = np.min([_bernstein(place, least, length) for place, length in marks], axis=0)
        needed = _DIGITS / (2 * np.log(np.minimum(front, load)[:, 0]))
    return np.searchsorted([len(nodes) for nodes, _ in _RULES[:-1]], needed)


def _bernstein(place: Array | float, depth: Array, length: Array) -> Array:
    """Parameter of the largest ellipse about [0, length] without the points place +- 2 i arsinh(sqrt(depth))."""
    height = 2 * np.arcsinh(np.sqrt(np.maximum(depth, 0.0)))
    wide = np.where(length > 0, length, 1.0)
    centre, height = 2 * place / wide - 1, 2 * height / wide
    # Sum of the distances to the foci -1 and 1 is rho + 1/rho.
    half = (np.hypot(centre - 1, height) + np.hypot(centre + 1, height)) / 2
    return np.where(length > 0, half + np.sqrt(np.maximum(half * half - 1, 0.0)), np.inf)


def _area(e: Ellipses, contact: Contact) -> Callable[[Array, Array], Array]:
    """The contact's log_area; its quicker form where every member slips by more than a twentieth of its load at some time."""
    return contact.log_area_in_sums if isinstance(contact, FlatRoundedContact) and np.all(_deep(e)) else contact.log_area


def _deep(e: Ellipses) -> NDArray[np.bool_]:
    """Whether P - P_c gets beyond a share of P0: at the ends of the phases, or in the middle of I-J."""
    ends = np.maximum(e.u, e.v) * np.sin(e.turn / 2) ** 2
    middle = 2 * e.amplitude * e.sine * np.sin(np.minimum(math.pi - e.turn, math.pi / 2))
    return (np.maximum(ends, middle) > _DEEP * e.mean)[:, 0]


def _works(e: Ellipses, contact: Contact, nodes: Array, weights: Array) -> tuple[Array, Array]:
    """Forward and reverse work of members (m,) by one rule on [0, 1]."""
    area = _area(e, contact)
    half = e.turn / 2 * nodes
    sine, cosine = np.sin(half), np.cos(half)
    sin_s, cos_s = 2 * sine * cosine, 1 - 2 * sine * sine
    with_c, with_s = e.cosine * cos_s, e.sine * sin_s
    half_sine, half_cosine = np.sin(e.turn / 2), np.cos(e.turn / 2)
    # sin((D - s)/2) and sin((D + s)/2)
    before, after = half_sine * cosine - half_cosine * sine, half_sine * cosine + half_cosine * sine
    reverse_rate = e.v * 2 * before * (half_cosine * cosine + half_sine * sine)
    eg = reverse_rate * area(e.load(with_c - with_s), e.u * sine * sine)
    jm = e.u * sin_s * area(e.load(with_c + with_s), e.v * after * after)
    half = (math.pi - e.turn) / 2 * nodes
    sine, cosine = np.sin(half), np.cos(half)
    sin_s, cos_s = 2 * sine * cosine, 1 - 2 * sine * sine
    ij = e.u * sin_s * area(e.load(e.sine * sin_s - e.cosine * cos_s), 2 * e.amplitude * e.sine * sin_s)
    turn = e.turn[:, 0]
    return turn * (jm @ weights) + (math.pi - turn) * (ij @ weights), turn * (eg @ weights)
