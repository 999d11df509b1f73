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
    """Shear and slip at points x (k,) by a density mu of flat punches over their half-width, for
    each of m hat functions as density: (k, m) each; the slip but for a constant.

        r(x) = (E*/2) int_x^a mu c dc/sqrt(c^2 - x^2),    w(x) = int_0^x mu c arccosh(x/c) dc

    A hat is 1 at one of the m + 1 half-widths and falls straight to 0 at its neighbours; the last
    half-width has the density of the one before. `modulus` is E*.
    """
    x_column = x[:, None]
    larger_width = np.maximum(half_widths, x_column)
    smaller_width = np.minimum(half_widths, x_column)
    root_of_squares = np.sqrt((larger_width - smaller_width) * (larger_width + smaller_width))
    with np.errstate(divide="ignore", invalid="ignore"):
        arccosh_term = np.where(smaller_width > 0, np.arccosh(larger_width / smaller_width), 0.0)
        arcsine_term = np.where(
            x_column > 0, np.arcsin(np.minimum(smaller_width / x_column, 1.0)), 0.0
        )
    # A punch within x makes no shear there.
    is_beyond = half_widths > x_column
    shear = np.where(is_beyond, root_of_squares, 0.0)  # int c dc/sqrt(c^2 - x^2)
    shear_moment = (
        larger_width * shear + np.where(is_beyond, x_column**2 * arccosh_term, 0.0)
    ) / 2  # int c^2
    # Of a range of punches beyond x only its part within x makes slip there.
    root_of_squares = np.where(is_beyond, 0.0, root_of_squares)
    arccosh_term = np.where(is_beyond, 0.0, arccosh_term)
    slip = (
        smaller_width**2 * arccosh_term + x_column * (x_column - root_of_squares)
    ) / 2  # int c arccosh(x/c) dc
    slip_moment = (
        smaller_width**3 * arccosh_term / 3
        + x_column * (x_column**2 * arcsine_term - smaller_width * root_of_squares) / 6
    )

    def hat_integrals(integral: Array, moment: Array) -> Array:
        begin_width = half_widths[:-1]
        length = np.diff(half_widths)
        integral_rise = np.diff(integral, axis=1)
        upper_part = (np.diff(moment, axis=1) - begin_width * integral_rise) / length
        lower_part = integral_rise - upper_part
        integrals = lower_part
        integrals[:, 1:] += upper_part[:, :-1]
        integrals[:, -1] += upper_part[:, -1]
        return integrals

    return modulus / 2 * hat_integrals(shear, shear_moment), hat_integrals(slip, slip_moment)


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
        """Extra shear and slip at distances x (k,) from the middle, and which of the points slip in
        it.

        They come from the slip zone inside the contact, in which the shear would else exceed f p. A
        point between two punches counts as slipping where both of them do.
        """
        shear_by_slopes, slip_by_slopes = _of_punches(x, self.half_widths, self.modulus)
        punch_below = np.searchsorted(self.half_widths, x, side="right") - 1
        is_inside = punch_below < len(self.zone)
        slips_beyond = np.append(self.slips[1:], False)
        slips_on_both_sides = (self.slips & slips_beyond)[
            np.minimum(punch_below, len(self.zone) - 1)
        ]
        return SlipAtPoints(
            shear=shear_by_slopes @ self.slopes,
            slip=self.shift + slip_by_slopes @ self.slopes,
            slips=is_inside & slips_on_both_sides,
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
    """The least extra slip inside the contact after which the shear nowhere exceeds the Coulomb
    limit, |q| <= f p.

    Where a stroke of slip ends while the curvature of the faces still changes, the edge comes to
    rest first; points further in slip on. The zone is found on a row of flat punches, which is
    divided around its ends.

    Parameters
    ----------
    tractions
        q and f p at points, before the extra slip
    sense
        direction of the slip inside, +1 or -1; that at the edge is of the other one
    half_width, ends
        a; (k,) half-widths at which slip begins or ends before the extra slip: q has a root there
    edge_of_stick
        the half-width outside of which the edge slips; a where it rests
    modulus
        E* [stress]

    Raises
    ------
    NotFoundError
        Where no slip zone is found.
    """
    slip_ends = ends[(ends > 0) & (ends < half_width * (1 - _AT_EDGE))]
    contact_at_instant = _Step(tractions, sense, half_width, slip_ends, edge_of_stick, modulus)
    equal_widths = half_width * np.sin(np.linspace(0.0, math.pi / 2, _PUNCHES + 1))
    # A punch next to an end would be of no width.
    is_apart = np.all(np.abs(equal_widths[:, None] - slip_ends) > half_width / _PUNCHES**2, axis=1)
    is_apart[[0, -1]] = True
    half_widths = np.union1d(equal_widths[is_apart], slip_ends)
    solution = _solved(contact_at_instant, half_widths, None)
    if solution is None:
        raise NotFoundError("no zone was found in which points inside the contact slip")
    for _ in range(_DIVISIONS):
        half_widths = _divided(half_widths, solution.slips, slip_ends)
        finer_solution = _solved(contact_at_instant, half_widths, solution)
        if finer_solution is None:
            # What is left beyond the limit is seen by the check of the Coulomb limit.
            return solution
        solution = finer_solution
    return solution


def _divided(half_widths: Array, slips: NDArray[np.bool_], slip_ends: Array) -> Array:
    """The half-widths with more of them around the ends of the slip zone, and around others."""
    numbers_of_ends = np.flatnonzero(slips[1:] != slips[:-1]) + 1
    numbers_of_ends = np.union1d(numbers_of_ends, np.searchsorted(half_widths, slip_ends))
    punches_around = (numbers_of_ends[:, None] + np.arange(-_AROUND_END, _AROUND_END)).ravel()
    punches = np.unique(np.clip(punches_around, 0, len(slips) - 1))
    shares = np.arange(1, _PARTS) / _PARTS
    new_widths = half_widths[punches, None] + np.diff(half_widths)[punches, None] * shares
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
    """Extra slip inside the contact by flat punches of given half-widths (n,), with the slip zone
    in which it brings |q| to f p; None where no zone settles.

    The zone, at first that of a coarser solution, is corrected until no point is beyond the limit
    and none slips backward. `step` has the tractions before the slip, its direction and the
    modulus.
    """
    points = half_widths[:-1]
    shear_by_slopes, slip_by_slopes = _of_punches(points, half_widths, step.modulus)
    shear, limit = step.tractions(points)
    excess = step.sense * shear - limit
    excess_of_reverse = -step.sense * shear - limit
    excess_tolerance = _ROUNDING * float(np.max(excess))
    is_at_edge = points >= step.edge_of_stick
    n_points = len(points)
    matrix = np.zeros((n_points + 1, n_points + 1))
    matrix[n_points, :n_points] = _of_force(half_widths)
    right_side = np.zeros(n_points + 1)
    zone_of_points = np.where(excess > excess_tolerance, _ON, _RESTS)
    if coarser_solution is not None:
        zone_of_points = coarser_solution.zone[
            np.searchsorted(coarser_solution.half_widths, points, side="right") - 1
        ]
    zone_of_points = np.where(is_at_edge, _BACK, zone_of_points)
    for trial in range(_MOST_ZONES):
        is_resting = zone_of_points == _RESTS
        matrix[:n_points, :n_points] = np.where(
            is_resting[:, None], slip_by_slopes, shear_by_slopes
        )
        matrix[:n_points, n_points] = is_resting
        right_side[:n_points] = np.where(zone_of_points == _ON, -step.sense * excess, 0.0)
        right_side[:n_points] += np.where(
            (zone_of_points == _BACK) & ~is_at_edge, step.sense * excess_of_reverse, 0.0
        )
        *slopes, shift = np.linalg.solve(matrix, right_side)
        added_shear = step.sense * (shear_by_slopes @ slopes)
        slip = step.sense * (slip_by_slopes @ slopes + shift)
        round_off = _ROUNDING * float(np.max(np.abs(slip)))
        turns_back = (zone_of_points == _ON) & (slip < -round_off)
        turns_back |= (zone_of_points == _BACK) & (slip > round_off) & ~is_at_edge
        new_zone_of_points = np.where(turns_back, _RESTS, zone_of_points)
        new_zone_of_points = np.where(
            is_resting & (excess + added_shear > excess_tolerance), _ON, new_zone_of_points
        )
        new_zone_of_points = np.where(
            is_resting & (excess_of_reverse - added_shear > excess_tolerance),
            _BACK,
            new_zone_of_points,
        )
        if np.array_equal(new_zone_of_points, zone_of_points):
            return InnerSlip(
                step.modulus,
                half_widths,
                np.array(slopes),
                float(shift),
                step.sense,
                zone_of_points,
            )
        changed_punches = np.flatnonzero(new_zone_of_points != zone_of_points)
        if trial > _AT_ONCE:
            changed_punches = changed_punches[:1]
        zone_of_points[changed_punches] = new_zone_of_points[changed_punches]
    return None
