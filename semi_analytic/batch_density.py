"""Pointwise dissipation of steady ellipses, and its peak: the letters and angles of `batch_ellipses`.

# notation: P_x load at which a = |x|; h half-angle about the least load within which x is open, 2 P1 sin^2(h/2) = P_x - P_min

While c < |x| < a(P), W(x) gathers (f A/pi) p(x, P) |rate| arccosh(|x|/c). The point is in contact for pi + h < t < 3 pi - h, and
the front passes it in E-G where sin^2((D - s)/2) = (P_x - P_T)/v, in I-J at s = t_E - h, in J-M where sin^2(s/2) = (P_x - P_T)/u.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semi_analytic.batch_cuts import angles, corner_loads
from semi_analytic.batch_ellipses import Ellipses, phase_of
from semi_analytic.batch_profiles import BatchContact, Profiles
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]

_CHUNK = 500
_GRID = np.arange(1, 24) / 24
_ZOOMS = 7


def density_of(e: Ellipses, contact: BatchContact | Profiles, x: Array) -> tuple[Array, Array]:
    """Forward and reverse part of W(x) pi E*/(2 f^2), arrays (m,): member k at |x| = x[k], in chunks."""
    profiles = contact if isinstance(contact, Profiles) else Profiles.of_one(contact)
    forward, reverse = np.zeros(len(x)), np.zeros(len(x))
    for first in range(0, len(x), _CHUNK):
        here = np.arange(first, min(first + _CHUNK, len(x)))
        forward[here], reverse[here] = _densities(e.take(here[:, None]), profiles.take(here), x[here, None])
    return forward, reverse


def _densities(e: Ellipses, profiles: Profiles, x: Array) -> tuple[Array, Array]:
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
                parts_of_work = _integral(name, e.take(member), some, x[member], edge[member], low, high)
                np.add.at(total[name], member, parts_of_work)
    return total["I-J"] + total["J-M"], total["E-G"]


def _marks(e: Ellipses, profiles: Profiles) -> dict[str, Array]:
    """Where a corner of the profile cuts the phases, (marks, m)."""
    corners = corner_loads(profiles.of(slice(None)))
    if not len(corners):
        return dict.fromkeys(("E-G", "I-J", "J-M"), np.empty((0, len(e.mean))))
    return angles(e.take((slice(None), 0)), np.broadcast_to(corners, (len(corners), len(e.mean))))


def _integral(name: str, e: Ellipses, contact: BatchContact, x: Array, edge: Array, begin: Array, end: Array) -> Array:
    """int p |rate| arccosh(|x|/c) ds over one range of one phase, (m,)."""
    s, weight = graded(begin, end)
    growth, slipped, load = phase_of(name, e, s)
    front = np.maximum(load - slipped, 0.0)
    reach = contact.reach(x, np.maximum(edge - front, 0.0), front)
    return np.sum(weight * growth * contact.pressure(x, load) * reach, axis=1)


def peak_of(e: Ellipses, contact: BatchContact | Profiles) -> tuple[Array, Array, Array]:
    """Largest W(x) pi E*/(2 f^2), its |x|, and that from permanent stick edge (0) to largest contact (1); arrays (m,)."""
    profiles = contact if isinstance(contact, Profiles) else Profiles.of_one(contact)
    found = np.empty((3, len(e.mean)))
    for members, some in profiles.groups(len(e.mean), (*profiles.alike, "exponent")):
        found[:, members] = _peaks(e.take(members), some)
    return found[0], found[1], found[2]


def _peaks(e: Ellipses, profiles: Profiles) -> tuple[Array, Array, Array]:
    """The best of a grid, then halving about it, then a parabola."""
    count = len(e.mean)
    contact = profiles.of(slice(None))
    inner, outer = contact.half_width(e.permanent), contact.half_width(e.mean + e.amplitude)

    def values(part: Array) -> Array:
        total = np.empty(part.shape)
        for column in range(part.shape[1]):
            total[:, column] = sum(density_of(e, profiles, inner + (outer - inner) * part[:, column]))
        return total

    grid = np.broadcast_to(_GRID, (count, len(_GRID)))
    found = values(grid)
    best = np.argmax(found, axis=1)
    rows = np.arange(count)
    middle, step = grid[rows, best], float(_GRID[0])
    top = found[rows, best]
    for zoom in range(_ZOOMS + 1):
        step /= 2 if zoom < _ZOOMS else 1
        lower, upper = values(np.stack([middle - step, middle + step], axis=1)).T
        if zoom == _ZOOMS:
            break
        middle = middle + np.where(lower > np.maximum(top, upper), -step, np.where(upper > top, step, 0.0))
        top = np.maximum(top, np.maximum(lower, upper))
    bend = lower + upper - 2 * top
    curved = (bend < 0) & (top >= lower) & (top >= upper)
    bend = np.where(curved, bend, -1.0)
    lean = np.where(curved, lower - upper, 0.0)
    place = middle + step * lean / (2 * bend)
    return top - lean**2 / (8 * bend), inner + (outer - inner) * place, place
