"""Slip zones that do not reach the edge of contact, where the memory curve breaks Coulomb's law.

Where a stroke of slip ends while the curvature of the faces still changes, the edge comes to rest
first, and points further in slip on. The memory curve (`corrected_memory`) meets q = f p there by
its resultant only: |q| is beyond f p by a share of second order in that curvature. Here the points
beyond it slip further, until |q| = f p, with the least slip that does so::

    sigma q <= f p,    sigma w >= 0,    one of the two with =,    int r dx = 0,

w being the slip that is added and r the shear that it makes. Both are a superposition of flat
punches, dM = mu dG, with mu straight between two half-widths c::

    r(x) = (E*/2) int_x^a mu c dc / sqrt(c^2 - x^2),    w(x) = C + int_0^x mu c arccosh(x/c) dc

Points outside `edge_of_stick` slip in the step itself: their q is at the limit, and r = 0 there.

While a contact of half-width a slips in |x| < b and rests outside, under steps of Q - f P and of
f kn - kt = beta < 0, this is in closed form (a test)::

    q - f p = beta (E*/2) |x| sqrt((x^2 - b^2)/(a^2 - x^2)),    Q - f P = beta [G(a) - G(b)]

# notation: q shear, p pressure, f friction coefficient, sigma = +1 forward, -1 reverse slip, G, kn,
#           kt, M as in `corrected_memory`
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import NotFoundError
from scenes.array_types import Array

Indices = NDArray[np.int64]

# Half-widths of punches at first, and how often and how finely those around an end of the zone are
# divided: q has a root there. 96 leave 10 % of what q is beyond the limit, four divisions 0.5 %.
_PUNCHES = 96
_DIVISIONS = 4
_PARTS = 4
# Punches on either side of an end of the zone that are divided.
_AROUND_END = 2
# What a point does: it slips on, rests, or slips as the edge does.
_ON, _RESTS, _BACK = 1, 0, -1
# Zones that are tried: some ten are.
_MOST_ZONES = 200
# The first of them may come back to one that was tried: after these one point is changed at a time.
_AT_ONCE = 30
# Share of a within which slip at the edge is too narrow to be told from an edge that rests.
_AT_EDGE = 1e-3
# Share of the largest excess, and of the largest slip, that is round-off.
_ROUNDING = 1e-9


def _of_punches(x: Array, half_widths: Array, modulus: float) -> tuple[Array, Array]:
    """r and w - C at points x (k,) of mu that is 1 at one half-width and straight to 0 at those
    beside it, (k, m) each; the last of the m+1 half-widths has the mu of the one before.
    """
    place = x[:, None]
    larger_width = np.maximum(half_widths, place)
    smaller_width = np.minimum(half_widths, place)
    root = np.sqrt((larger_width - smaller_width) * (larger_width + smaller_width))
    with np.errstate(divide="ignore", invalid="ignore"):
        arc = np.where(smaller_width > 0, np.arccosh(larger_width / smaller_width), 0.0)
        turn = np.where(place > 0, np.arcsin(np.minimum(smaller_width / place, 1.0)), 0.0)
    # Of a punch within x nothing counts for r.
    is_beyond = half_widths > place
    shear = np.where(is_beyond, root, 0.0)  # int c dc/sqrt(c^2 - x^2)
    shear_moment = (larger_width * shear + np.where(is_beyond, place**2 * arc, 0.0)) / 2  # int c^2
    # Of a punch beyond x only its part within x counts for w.
    root = np.where(is_beyond, 0.0, root)
    arc = np.where(is_beyond, 0.0, arc)
    slip = (smaller_width**2 * arc + place * (place - root)) / 2  # int c arccosh(x/c) dc
    slip_moment = smaller_width**3 * arc / 3 + place * (place**2 * turn - smaller_width * root) / 6

    def hats(integral: Array, moment: Array) -> Array:
        begin = half_widths[:-1]
        length = np.diff(half_widths)
        rise = np.diff(integral, axis=1)
        upper_part = (np.diff(moment, axis=1) - begin * rise) / length
        lower_part = rise - upper_part
        of_hats = lower_part
        of_hats[:, 1:] += upper_part[:, :-1]
        of_hats[:, -1] += upper_part[:, -1]
        return of_hats

    return modulus / 2 * hats(shear, shear_moment), hats(slip, slip_moment)


class SlipAtPoints(NamedTuple):
    """r [stress], w [length] and whether they slip in the sense of the zone, of points (k,); that
    sense.
    """

    shear: Array
    slip: Array
    slips: NDArray[np.bool_]
    sense: int


@dataclass(frozen=True, eq=False)
class InnerSlip:
    """What slips further at an instant.

    Attributes
    ----------
    modulus
        E*
    half_widths
        (m+1,) of the punches, from 0 to a
    slopes
        (m,) mu at all but the last of them [1 / length]
    shift
        C [length]
    sense
        sigma, +1 or -1
    zone
        (m,) what the points at all but the last half-width do
    """

    modulus: float
    half_widths: Array
    slopes: Array
    shift: float
    sense: int
    zone: Indices

    @property
    def slips(self) -> NDArray[np.bool_]:
        """(m,) whether they slip in that sense."""
        return np.asarray(self.zone == _ON)

    def at(self, x: Array) -> SlipAtPoints:
        """What slips further at distances x (k,) from the middle."""
        of_shear, of_slip = _of_punches(x, self.half_widths, self.modulus)
        number = np.searchsorted(self.half_widths, x, side="right") - 1
        is_inside = number < len(self.zone)
        next_slips = np.append(self.slips[1:], False)
        slips = (self.slips & next_slips)[np.minimum(number, len(self.zone) - 1)]
        return SlipAtPoints(
            shear=of_shear @ self.slopes,
            slip=self.shift + of_slip @ self.slopes,
            slips=is_inside & slips,
            sense=self.sense,
        )


# q and f p of the memory curve at points x (k,): (k,) each [stress].
Tractions = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class _Step:
    """The contact at an instant: q and f p of the memory curve, sigma, a, half-widths at which
    slip of the memory curve begins and ends, that outside of which the edge slips, E*.
    """

    tractions: Tractions
    sense: int
    half_width: float
    ends: Array
    edge_of_stick: float
    modulus: float


def inner_slip(
    tractions: Tractions,
    sense: int,
    half_width: float,
    ends: Array,
    edge_of_stick: float,
    modulus: float,
) -> InnerSlip:
    """The least slip after which |q| is at most f p.

    Parameters
    ----------
    tractions
        q and f p of the memory curve at points
    sense
        sigma of the slip inside; that at the edge is of the other sense
    half_width, ends
        a; (k,) half-widths at which slip of the memory curve begins or ends: q has a root there
    edge_of_stick
        the half-width outside of which the edge slips; a where it rests

    Raises
    ------
    NotFoundError
        Where no slip zone is found.
    """
    slip_ends = ends[(ends > 0) & (ends < half_width * (1 - _AT_EDGE))]
    step = _Step(tractions, sense, half_width, slip_ends, edge_of_stick, modulus)
    equal_widths = half_width * np.sin(np.linspace(0.0, math.pi / 2, _PUNCHES + 1))
    # A punch next to an end would be of no width.
    is_apart = np.all(np.abs(equal_widths[:, None] - slip_ends) > half_width / _PUNCHES**2, axis=1)
    is_apart[[0, -1]] = True
    half_widths = np.union1d(equal_widths[is_apart], slip_ends)
    solution = _solved(step, half_widths, None)
    if solution is None:
        raise NotFoundError("no zone was found in which points inside the contact slip")
    for _ in range(_DIVISIONS):
        half_widths = _divided(half_widths, solution.slips, slip_ends)
        finer_solution = _solved(step, half_widths, solution)
        if (
            finer_solution is None
        ):  # what is left beyond the limit is looked at by whoever has the fields
            return solution
        solution = finer_solution
    return solution


def _divided(half_widths: Array, slips: NDArray[np.bool_], slip_ends: Array) -> Array:
    """The half-widths with more of them around the ends of the slip zone, and around others."""
    ends = np.flatnonzero(slips[1:] != slips[:-1]) + 1
    ends = np.union1d(ends, np.searchsorted(half_widths, slip_ends))
    punches_around = (ends[:, None] + np.arange(-_AROUND_END, _AROUND_END)).ravel()
    punches = np.unique(np.clip(punches_around, 0, len(slips) - 1))
    share = np.arange(1, _PARTS) / _PARTS
    new_widths = half_widths[punches, None] + np.diff(half_widths)[punches, None] * share
    return np.union1d(half_widths, new_widths)


def _of_force(half_widths: Array) -> Array:
    """int r dx over pi E*/2 of the same mu, int mu c dc: (m,)."""
    begin = half_widths[:-1]
    length = np.diff(half_widths)
    upper_part = length * (begin / 2 + length / 3)
    force = length * (begin / 2 + length / 6)
    force[1:] += upper_part[:-1]
    force[-1] += upper_part[-1]
    return np.asarray(force)


def _solved(
    step: _Step, half_widths: Array, coarser_solution: InnerSlip | None
) -> InnerSlip | None:
    """Slip by punches of given half-widths: the zone, at first that of a coarser answer, is
    corrected until no point is beyond the limit and none slips backward; None where that has no
    end.
    """
    points = half_widths[:-1]
    of_shear, of_slip = _of_punches(points, half_widths, step.modulus)
    shear, limit = step.tractions(points)
    excess = step.sense * shear - limit
    excess_back = -step.sense * shear - limit
    allowed_excess = _ROUNDING * float(np.max(excess))
    at_edge = points >= step.edge_of_stick
    count = len(points)
    matrix = np.zeros((count + 1, count + 1))
    matrix[count, :count] = _of_force(half_widths)
    right = np.zeros(count + 1)
    zone = np.where(excess > allowed_excess, _ON, _RESTS)
    if coarser_solution is not None:
        zone = coarser_solution.zone[
            np.searchsorted(coarser_solution.half_widths, points, side="right") - 1
        ]
    zone = np.where(at_edge, _BACK, zone)
    for trial in range(_MOST_ZONES):
        rests = zone == _RESTS
        matrix[:count, :count] = np.where(rests[:, None], of_slip, of_shear)
        matrix[:count, count] = rests
        right[:count] = np.where(zone == _ON, -step.sense * excess, 0.0)
        right[:count] += np.where((zone == _BACK) & ~at_edge, step.sense * excess_back, 0.0)
        *slopes, shift = np.linalg.solve(matrix, right)
        added_shear = step.sense * (of_shear @ slopes)
        slip = step.sense * (of_slip @ slopes + shift)
        round_off = _ROUNDING * float(np.max(np.abs(slip)))
        turns_back = (zone == _ON) & (slip < -round_off)
        turns_back |= (zone == _BACK) & (slip > round_off) & ~at_edge
        new_zone = np.where(turns_back, _RESTS, zone)
        new_zone = np.where(rests & (excess + added_shear > allowed_excess), _ON, new_zone)
        new_zone = np.where(rests & (excess_back - added_shear > allowed_excess), _BACK, new_zone)
        if np.array_equal(new_zone, zone):
            return InnerSlip(
                step.modulus, half_widths, np.array(slopes), float(shift), step.sense, zone
            )
        changed_punches = np.flatnonzero(new_zone != zone)
        if trial > _AT_ONCE:
            changed_punches = changed_punches[:1]
        zone[changed_punches] = new_zone[changed_punches]
    return None
