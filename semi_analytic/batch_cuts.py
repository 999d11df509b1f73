"""Friction work of steady ellipses where Lam is smooth only in parts, or where nobody knows: any profile.

# notation: as in `batch_ellipses`; P_b load of a corner of the profile

Each phase is cut at the angles at which P or P_c is the load of a corner:

    P = P_b    cos t = (P_b - P0)/P1:            E-G  t_E + s = t,     I-J  t_E + s = t +- pi,   J-M  t_E - s = +-t
    P_c = P_b  E-G  v sin^2((D - s)/2) = P_b - P_T,   J-M  u sin^2(s/2) = P_b - P_T,   I-J  t_E - s = t +- pi

Between the cuts, and next to corners that are just not met, the rule for singular ends applies; pieces on which it and its
coarser half do not agree are halved, and halved again.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from semi_analytic.batch_ellipses import Ellipses, phase_of
from semi_analytic.batch_profiles import BatchContact, Profiles
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_MEMBERS = 64
_PIECES = 1024
_SETTLED = 1e-10
_PATIENT, _NOTHING = 3, 1e-14
_LEVELS = 16


def works_in_pieces(e: Ellipses, profiles: Profiles) -> tuple[Array, Array]:
    """Forward and reverse part of W pi/(2 f^2) E*, arrays (m,), in chunks."""
    count = len(e.mean)
    forward, reverse = np.zeros(count), np.zeros(count)
    for members, some in profiles.groups(count):
        for first in range(0, len(members), _MEMBERS):
            part = np.arange(first, min(first + _MEMBERS, len(members)))
            here = members[part]
            works = _works(e.take(here), some.take(part))
            forward[here], reverse[here] = works["I-J"] + works["J-M"], works["E-G"]
    return forward, reverse


def corner_loads(contact: BatchContact) -> Array:
    """P_b of the corners (c, 1), or (c, m) where the parameters of the profile are arrays."""
    loads = getattr(contact, "corner_loads", None)
    if loads is not None:
        return np.asarray(loads)
    breaks = np.array(getattr(contact, "breaks", ()), dtype=float)
    return contact.load(breaks)[:, None] if len(breaks) else np.empty((0, 1))


def _works(e: Ellipses, profiles: Profiles) -> dict[str, Array]:
    corners = np.broadcast_to(loads := corner_loads(profiles.of(slice(None))), (len(loads), len(e.mean)))
    pieces = {name: _pieces(marks) for name, marks in angles(e, corners).items()}
    rough = {name: _measured(name, e, profiles, *piece) for name, piece in pieces.items()}
    size = sum(np.bincount(pieces[name][0], weights=rough[name][0], minlength=len(e.mean)) for name in pieces)
    return {name: _settled(name, e, profiles, pieces[name], rough[name], np.asarray(size)) for name in pieces}


def angles(e: Ellipses, corners: Array) -> dict[str, Array]:
    """Ends of the pieces of each phase, ascending, (marks, m), for corners (c, m)."""
    cosine = (corners - e.mean) / np.where(e.moving, e.amplitude, np.inf)
    above = np.maximum(corners - e.permanent, 0.0)
    # Corners that are not met, but nearly: a cut at the greatest or least load.
    high, low = np.arccos(np.clip(cosine, -1.0, 1.0)), np.arccos(np.clip(-cosine, -1.0, 1.0))
    by_v, by_u = (2 * np.arcsin(np.sqrt(np.minimum(above / np.where(size > 0, size, np.inf), 1.0))) for size in (e.v, e.u))
    start, full = e.start, 2 * math.pi
    inside = {
        "E-G": (high - start, full - high - start, e.turn - by_v),
        "I-J": (low - start, full - low - start, start - low, start + low),
        "J-M": (start - high, start + high, by_u),
    }
    length = {"E-G": e.turn, "I-J": math.pi - e.turn, "J-M": e.turn}
    return {name: _ascending([np.zeros_like(start), *inside[name], length[name]]) for name in inside}


def _ascending(marks: Iterable[Array]) -> Array:
    """Marks (m,) or (c, m) between the first and the last, in order: (marks, m)."""
    rows = np.concatenate([np.atleast_2d(mark) for mark in marks])
    return np.sort(np.clip(rows, rows[0], rows[-1]), axis=0)


def _pieces(marks: Array) -> tuple[Indices, Array, Array]:
    """Member, begin and end of each piece that is not empty."""
    low, high = marks[:-1], marks[1:]
    number, member = np.nonzero(high - low > 1e-14 * marks[-1])
    return member, low[number, member], high[number, member]


def _measured(name: str, e: Ellipses, profiles: Profiles, member: Indices, begin: Array, end: Array) -> Array:
    """Integrals of rate times Lam over pieces by the rule with all, every second and every fourth node: (3, pieces)."""
    values = np.empty((3, len(member)))
    for first in range(0, len(member), _PIECES):
        here = slice(first, first + _PIECES)
        s, weight = graded(begin[here], end[here])
        rate, slipped, load = phase_of(name, e.take(member[here, None]), s)
        terms = weight * rate * profiles.of(member[here, None]).log_area(load, np.minimum(slipped, load))
        for k in range(3):
            values[k, here] = 2**k * np.sum(terms[:, :: 2**k], axis=1)
    return values


def quadrature_error(values: Array, size: Array) -> Array:
    """Error of the full rule over `size`, from above: what it and the next coarser rule differ by, or if that falls like an
    exponential as it does where all is smooth, the power 1.5 of it (the power 2 would be just)."""
    near, far = (np.abs(values[k] - values[k + 1]) / np.where(size > 0, size, 1.0) for k in (0, 1))
    return np.where(near <= far**1.5, near**1.5, near)


def _settled(name: str, e: Ellipses, profiles: Profiles, pieces: tuple[Indices, Array, Array], rough: Array, size: Array) -> Array:
    """The work of one phase, (m,): pieces in halves until each is known to 1e-10 of the whole, or after a few to 1e-14 P0^2;
    NaN if that does not happen.
    """
    (member, begin, end), values, total = pieces, rough, np.zeros(len(size))
    for level in range(_LEVELS):
        error = quadrature_error(values, size[member])
        done = ~(error > _SETTLED) | ((level >= _PATIENT) & (error * size[member] <= _NOTHING * np.square(e.mean[member])))
        np.add.at(total, member[done], values[0, done])
        member, begin, end = member[~done], begin[~done], end[~done]
        if not len(member):
            return total
        middle = (begin + end) / 2
        member, begin, end = np.tile(member, 2), np.concatenate([begin, middle]), np.concatenate([middle, end])
        values = _measured(name, e, profiles, member, begin, end)
    total[member] = np.nan
    return total
