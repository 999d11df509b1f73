"""Dissipation of many steady ellipses in one call; letters and angles of `batch_ellipses`."""

from __future__ import annotations

import math
from enum import IntEnum
from functools import partial

import numpy as np
from numpy.typing import NDArray

from semi_analytic.batch_cuts import works_in_pieces
from semi_analytic.batch_ellipses import Ellipses
from semi_analytic.batch_flat import LOW, area_at_all_loads, area_at_low_loads, careful_area
from semi_analytic.batch_kernel import ROWS, Area, Room, bracket, members_at_once, sums
from semi_analytic.batch_profiles import BatchContact, Profiles
from semi_analytic.batch_rules import RULES, rule_of
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.hertz import HertzContact, log_excess
from semi_analytic.power_law import PowerLawContact

Array = NDArray[np.float64]

_DEEP = 0.02
_FLOOR = 1e-200
_LOW, _CAREFUL, _WAYS = 1, 2, 4


class Reason(IntEnum):
    """Why a member of a batch has no value."""

    NONE = 0
    SLIDING = 1
    SEPARATION = 2
    INVALID = 3
    EXTENT = 4
    UNSETTLED = 5


def dissipation_of(ellipses: Ellipses, contact: BatchContact | Profiles, *, careful: bool = False) -> tuple[Array, Array]:
    """Forward and reverse part of W pi/(2 f^2) E*, arrays (m,): each member by as many nodes as it needs, in chunks.

    Quick ways to Lam lose 6e-11 of W where P - P_c gets to a fiftieth of P0 only, 1e-12 at a fifth; `careful` ones, which take 4
    times as long on flat faces, keep 1e-14.
    """
    profiles = contact if isinstance(contact, Profiles) else Profiles.of_one(contact)
    if profiles.alike or not isinstance(everyone := profiles.of(slice(None)), HertzContact | PowerLawContact | FlatRoundedContact):
        return works_in_pieces(ellipses, profiles)
    e, room, spare = ellipses, Room(), Room()
    tier = rule_of(e.mean, e.amplitude, e.u, e.v, e.start, e.turn, e.permanent)
    # Members alike together: the same rule, and the same way to Lam.
    kind = _WAYS * tier + (_ways(e, everyone) | (_CAREFUL * careful))
    order = np.argsort(kind, kind="stable")
    loops, found = _rows(e).take(order, axis=1), np.empty((3, len(order)))
    ends = np.cumsum(np.bincount(kind, minlength=_WAYS * len(RULES)))
    for number in np.flatnonzero(np.diff(ends, prepend=0)).tolist():
        nodes, weights = RULES[number // _WAYS]
        step = members_at_once(len(nodes))
        for begin in range(ends[number - 1] if number else 0, ends[number], step):
            here = slice(begin, min(begin + step, ends[number]))
            area = _area(profiles.of(order[here]), number % _WAYS, spare)
            found[:, order[here]] = sums(loops[:, here], nodes, weights, area, room)
    return _works(e, everyone, found)


def _rows(e: Ellipses) -> Array:
    """What `sums` takes, (9, m)."""
    rows = np.empty((ROWS, len(e.mean)))
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


def _ways(e: Ellipses, contact: BatchContact) -> NDArray[np.uint8]:
    """How to find Lam: quickly where P - P_c gets beyond a share of P0 at the ends of the phases or in the middle of I-J."""
    ends = np.maximum(e.u, e.v) * np.square(_less_than_sine(e.turn / 2))
    middle = 2 * e.amplitude * e.sine * _less_than_sine(np.minimum(math.pi - e.turn, math.pi / 2))
    # Where u is next to nothing, as at tangency, a phase with no slip to speak of would add rounding times v.
    unlike = np.minimum(e.u, e.v) <= _DEEP * np.maximum(e.u, e.v)
    shallow = (np.maximum(ends, middle) <= _DEEP * e.mean) | unlike
    low = isinstance(contact, FlatRoundedContact) and e.mean + e.amplitude <= LOW * contact.unit
    return (_LOW * low + _CAREFUL * shallow).astype(np.uint8)


def _less_than_sine(angle: Array) -> Array:
    """A bound close to the sine of angles up to a right one."""
    return angle * (1 - angle * angle / 6)


def _area(contact: BatchContact, way: int, room: Room) -> Area:
    """What `sums` adds up: Lam, or for power laws (Hertz among them) the bracket that all of them have in common."""
    if not isinstance(contact, FlatRoundedContact):
        return _careful_bracket if way & _CAREFUL else bracket
    if way & _CAREFUL:
        return partial(careful_area, bool(way & _LOW), contact, room)
    return _phase_by_phase(partial(area_at_low_loads if way & _LOW else area_at_all_loads, contact, room))


def _phase_by_phase(area: Area) -> Area:
    """One phase after the other: their arrays stay in the cache."""

    def each(front: Array, slipped: Array, free: Array) -> Array:
        for k in range(len(front)):
            area(front[k], slipped[k], free[k])
        return free

    return each


def _careful_bracket(front: Array, slipped: Array, free: Array) -> Array:
    """`bracket` to rounding of itself."""
    del free
    front += slipped
    return front * log_excess(slipped / front)


def _share(contact: BatchContact) -> Array | float:
    """Lam over what `_area` gives."""
    if isinstance(contact, PowerLawContact):
        return 1 / contact.exponent
    return 0.5 if isinstance(contact, HertzContact) else 1.0


def _works(e: Ellipses, contact: BatchContact, found: Array) -> tuple[Array, Array]:
    """Forward and reverse work from the sums (3, m)."""
    reverse, later, early = found * (2 * _share(contact))
    k = 4 * e.amplitude * e.sine
    early *= (math.pi - e.turn) * e.u / np.where(k > _FLOOR * e.mean, k, np.inf)
    later *= e.turn * e.u
    reverse *= e.turn * e.v
    return later + early, reverse
