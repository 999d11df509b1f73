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
_FIRST_PUNCHES = 96
_MOST_DIVISIONS = 4
_PARTS_OF_INTERVAL = 4
# Punches on either side of an end of the zone that are divided.
_PUNCHES_AROUND_END = 2
# Friction state of a point: it slips in the direction `direction`, sticks, or slips the other way,
# as the edge does.
_SLIPPING = 1
_STICKING = 0
_SLIPPING_BACK = -1
# Trials of the slip zone (active set) at most: some ten are needed.
_MOST_TRIALS = 200
# Trials in which all wrong points change at once. They may come back to a zone that was tried:
# later ones change one point at a time.
_TRIALS_OF_ALL_POINTS = 30
# Share of a within which slip at the edge is too narrow to be told from an edge that rests.
_EDGE_WIDTH_SHARE = 1e-3
# Share of the largest excess, and of the largest slip, that is round-off.
_ROUND_OFF_SHARE = 1e-9


def _shear_and_slip_of_punches(x: Array, half_widths: Array, modulus: float) -> tuple[Array, Array]:
    """Influence matrices of flat punches: shear r [stress * length] and slip w [length^2] at
    points x (k,) per unit of their density mu at each half-width, (k, m) both.

        r(x) = (E*/2) int_x^a mu c dc/sqrt(c^2 - x^2),    w(x) = int_0^x mu c arccosh(x/c) dc

    mu [1/length] is straight between the m + 1 half-widths, a sum of hat functions. A hat is 1 at
    one half-width and 0 at the others; the last half-width has the mu of the one before. The slip
    is relative to that at x = 0. A punch of half-width c carries the tangential load (pi E*/2) mu c
    dc. `modulus` is E* [stress].
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
    # Primitives over c of both kernels, and of c times the kernels, at each half-width: (k, m + 1).
    # A punch that ends within x makes no shear there.
    ends_beyond_x = half_widths > x_column
    shear_primitive = np.where(ends_beyond_x, root_of_squares, 0.0)  # int c dc/sqrt(c^2 - x^2)
    shear_moment_primitive = (
        larger_width * shear_primitive + np.where(ends_beyond_x, x_column**2 * arccosh_term, 0.0)
    ) / 2  # int c^2 dc/sqrt(c^2 - x^2)
    # Of a range of punches that ends beyond x only its part within x makes slip there.
    root_of_squares = np.where(ends_beyond_x, 0.0, root_of_squares)
    arccosh_term = np.where(ends_beyond_x, 0.0, arccosh_term)
    slip_primitive = (
        smaller_width**2 * arccosh_term + x_column * (x_column - root_of_squares)
    ) / 2  # int c arccosh(x/c) dc
    slip_moment_primitive = (
        smaller_width**3 * arccosh_term / 3
        + x_column * (x_column**2 * arcsine_term - smaller_width * root_of_squares) / 6
    )  # int c^2 arccosh(x/c) dc
    shear_of_hats = _integrals_over_hats(half_widths, shear_primitive, shear_moment_primitive)
    return modulus / 2 * shear_of_hats, _integrals_over_hats(
        half_widths, slip_primitive, slip_moment_primitive
    )


def _integrals_over_hats(half_widths: Array, primitive: Array, moment_primitive: Array) -> Array:
    """Integrals over half-widths c of a kernel times each hat function, (k, m) at k points.

    A hat is 1 at one of the `half_widths` (m + 1,) and 0 at the others, straight in between. The
    kernel is given by primitives over c at the half-widths, (k, m + 1): `primitive` of the kernel,
    `moment_primitive` of c times it.
    """
    lower_width = half_widths[:-1]
    interval_length = np.diff(half_widths)
    kernel_integral = np.diff(primitive, axis=1)
    moment_integral = np.diff(moment_primitive, axis=1)
    # On an interval the hat of its upper end rises from 0 to 1, that of its lower end falls.
    integral_with_rising_hat = (moment_integral - lower_width * kernel_integral) / interval_length
    hat_integrals = kernel_integral - integral_with_rising_hat
    hat_integrals[:, 1:] += integral_with_rising_hat[:, :-1]
    # The last half-width has the mu of the one before: their hats are one.
    hat_integrals[:, -1] += integral_with_rising_hat[:, -1]
    return hat_integrals


class SlipAtPoints(NamedTuple):
    """What the extra slip adds at points (k,): shear r [stress] and slip w [length]; whether each
    point lies in its slip zone; `direction` of that slip, +1 or -1.
    """

    shear: Array
    slip: Array
    is_slipping: NDArray[np.bool_]
    direction: int


@dataclass(frozen=True, eq=False)
class InnerSlip:
    """Extra slip inside the contact at an instant, as a superposition of flat punches.

    Attributes
    ----------
    modulus
        E* [stress]
    half_widths
        (m+1,) of the punches, from 0 to a [length]
    densities
        (m,) mu at all but the last of them [1 / length]
    slip_at_middle
        C, the slip at x = 0 [length]
    direction
        sigma, direction of the extra slip, +1 or -1
    friction_states
        (m,) of the points at all but the last half-width: 1 slips, 0 sticks, -1 slips the other way
    """

    modulus: float
    half_widths: Array
    densities: Array
    slip_at_middle: float
    direction: int
    friction_states: Indices

    @property
    def is_slipping(self) -> NDArray[np.bool_]:
        """(m,) whether the points at all but the last half-width slip in `direction`."""
        return np.asarray(self.friction_states == _SLIPPING)

    def at_points(self, x: Array) -> SlipAtPoints:
        """Shear [stress] and slip [length] that the extra slip adds at distances x (k,) >= 0 from
        the middle, and whether each point lies in its slip zone.

        The caller adds them to the fields of the memory curve, the tangential force carried up to
        each load. With those alone |q| exceeds f p inside the contact. A point between two
        half-widths counts as slipping where both of them slip: `is_slipping` (m,) is that of all
        but the last of the `half_widths` (m + 1,). `densities` (m,) are the mu of the punches,
        `slip_at_middle` is the slip at x = 0.
        """
        # influence matrices (k, m)
        shear_per_density, slip_per_density = _shear_and_slip_of_punches(
            x, self.half_widths, self.modulus
        )
        index_of_half_width_within = np.searchsorted(self.half_widths, x, side="right") - 1
        is_inside_contact = index_of_half_width_within < len(self.is_slipping)
        next_point_slips = np.append(self.is_slipping[1:], False)
        slips_at_both_ends = (self.is_slipping & next_point_slips)[
            np.minimum(index_of_half_width_within, len(self.is_slipping) - 1)
        ]
        return SlipAtPoints(
            shear=shear_per_density @ self.densities,
            slip=self.slip_at_middle + slip_per_density @ self.densities,
            is_slipping=is_inside_contact & slips_at_both_ends,
            direction=self.direction,
        )


# q and f p of the memory curve at points x (k,): (k,) each [stress].
Tractions = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class _MemoryContact:
    """The contact at an instant before the extra slip.

    Attributes
    ----------
    tractions
        function of points x (k,): q and f p of the memory curve, (k,) each [stress]
    direction
        sigma, direction of the extra slip, +1 or -1
    half_width
        a [length]
    slip_ends
        (j,) half-widths at which slip by the memory curve begins or ends [length]
    stick_half_width
        the half-width outside of which the edge slips by the memory curve; a where it sticks
    modulus
        E* [stress]
    """

    tractions: Tractions
    direction: int
    half_width: float
    slip_ends: Array
    stick_half_width: float
    modulus: float


def inner_slip(
    tractions: Tractions,
    direction: int,
    half_width: float,
    ends: Array,
    edge_of_stick: float,
    modulus: float,
) -> InnerSlip:
    """The least slip inside the contact that must be added to that of the memory curve, so that the
    shear keeps the Coulomb limit |q| <= f p everywhere.

    The memory curve is the tangential force carried up to each load. Where slip in one direction
    ends while the curvature of the faces still changes, points at the edge of contact stick first;
    points further in slip on. The extra slip is a superposition of flat punches, of about 100
    half-widths at first. The half-widths are refined around the edges of its zone four times, or
    until the search for the zone fails.

    Parameters
    ----------
    tractions
        function of points x (k,): q and f p of the memory curve, (k,) each [stress]
    direction
        direction of the extra slip, +1 or -1; slip at the edge has the other one
    half_width
        a [length]
    ends
        (k,) distances from the middle at which slip of the memory curve begins or ends, where
        q varies like a square root [length]
    edge_of_stick
        distance from the middle beyond which the edge slips; a where it sticks [length]
    modulus
        E* [stress]

    Raises
    ------
    NotFoundError
        Where no slip zone is found with the first half-widths.
    """
    # _EDGE_WIDTH_SHARE: 1e-3
    slip_ends = ends[(ends > 0) & (ends < half_width * (1 - _EDGE_WIDTH_SHARE))]
    contact = _MemoryContact(tractions, direction, half_width, slip_ends, edge_of_stick, modulus)
    # 97 half-widths, closer together at the edge of contact
    graded_half_widths = half_width * np.sin(np.linspace(0.0, math.pi / 2, _FIRST_PUNCHES + 1))
    # The interval between a half-width and a slip end next to it would have no length.
    is_apart_from_ends = np.all(
        np.abs(graded_half_widths[:, None] - slip_ends) > half_width / _FIRST_PUNCHES**2, axis=1
    )
    is_apart_from_ends[[0, -1]] = True
    punch_half_widths = np.union1d(graded_half_widths[is_apart_from_ends], slip_ends)
    # None where the search does not converge
    extra_slip = _slip_on_punches(contact, punch_half_widths, None)
    if extra_slip is None:
        raise NotFoundError("no zone was found in which points inside the contact slip")
    for _ in range(_MOST_DIVISIONS):
        punch_half_widths = _refined_half_widths(
            punch_half_widths, extra_slip.is_slipping, slip_ends
        )
        finer_solution = _slip_on_punches(contact, punch_half_widths, extra_slip)
        if finer_solution is None:
            # The check of the Coulomb limit then states by how much the coarser one exceeds it.
            return extra_slip
        extra_slip = finer_solution
    return extra_slip


def _refined_half_widths(
    half_widths: Array, is_slipping: NDArray[np.bool_], slip_ends: Array
) -> Array:
    """The half-widths, ascending, with more of them around the ends of the zone of extra slip and
    around `slip_ends`, where slip by the memory curve begins or ends.

    The memory curve is the tangential force carried up to each load. The two intervals on each side
    of such an end are cut into four parts each. `is_slipping` (m,) states for all half-widths but
    the last whether points there are in the zone of extra slip.
    """
    # indices of the half-widths at which a zone ends
    indices_of_ends = np.flatnonzero(is_slipping[1:] != is_slipping[:-1]) + 1
    indices_of_ends = np.union1d(indices_of_ends, np.searchsorted(half_widths, slip_ends))
    intervals_around = (
        indices_of_ends[:, None] + np.arange(-_PUNCHES_AROUND_END, _PUNCHES_AROUND_END)
    ).ravel()
    intervals = np.unique(np.clip(intervals_around, 0, len(is_slipping) - 1))
    shares_of_interval = np.arange(1, _PARTS_OF_INTERVAL) / _PARTS_OF_INTERVAL
    added_half_widths = (
        half_widths[intervals, None] + np.diff(half_widths)[intervals, None] * shares_of_interval
    )
    return np.union1d(half_widths, added_half_widths)


def _force_of_punches(half_widths: Array) -> Array:
    """Tangential force int r dx of each hat function of mu, divided by pi E*/2: int mu c dc, (m,).

    A hat function is 1 at one half-width c and 0 at the others. mu is the density of flat punches,
    r their shear.
    """
    lower_width = half_widths[:-1]
    interval_length = np.diff(half_widths)
    force_of_rising_hats = interval_length * (lower_width / 2 + interval_length / 3)
    force_of_hats = interval_length * (lower_width / 2 + interval_length / 6)
    force_of_hats[1:] += force_of_rising_hats[:-1]
    # The last half-width has the mu of the one before: their hats are one.
    force_of_hats[-1] += force_of_rising_hats[-1]
    return np.asarray(force_of_hats)


@dataclass(frozen=True, eq=False)
class _PunchProblem:
    """Matrices and limits of the equations for the extra slip by flat punches of given half-widths.
    Its m points are all half-widths but the last.

    Attributes
    ----------
    direction
        sigma, direction of the extra slip, +1 or -1
    shear_per_density, slip_per_density
        (m, m) influence matrices: shear and slip at the points by a unit of the density mu at each
    force_per_density
        (m,) tangential force, over pi E*/2, by a unit of mu at each point
    excess
        (m,) sigma q - f p of the memory curve: by how much slip along sigma is beyond the Coulomb
        limit [stress]
    excess_of_reverse_slip
        (m,) -sigma q - f p [stress]
    excess_tolerance
        excess that is round-off [stress]
    is_at_edge
        (m,) whether the point is in the slip zone next to the edge, which slips by the memory
        curve already
    """

    direction: int
    shear_per_density: Array
    slip_per_density: Array
    force_per_density: Array
    excess: Array
    excess_of_reverse_slip: Array
    excess_tolerance: float
    is_at_edge: NDArray[np.bool_]

    @classmethod
    def of_contact(cls, contact: _MemoryContact, half_widths: Array) -> _PunchProblem:
        """Coefficients of the equations for the extra slip of a contact, by flat punches of given
        half-widths (m + 1,): shear and slip per density of punches, and what q exceeds f p by.

        `contact` holds q and f p of the memory curve as functions of x, the direction of the extra
        slip, E*, and the half-width outside of which the edge slips. The m points are all
        half-widths but the last.
        """
        direction = contact.direction
        points = half_widths[:-1]
        shear_per_density, slip_per_density = _shear_and_slip_of_punches(
            points, half_widths, contact.modulus
        )
        shear, coulomb_limit = contact.tractions(points)
        excess = direction * shear - coulomb_limit
        return cls(
            direction=direction,
            shear_per_density=shear_per_density,
            slip_per_density=slip_per_density,
            force_per_density=_force_of_punches(half_widths),
            excess=excess,
            excess_of_reverse_slip=-direction * shear - coulomb_limit,
            # _ROUND_OFF_SHARE: 1e-9
            excess_tolerance=_ROUND_OFF_SHARE * float(np.max(excess)),
            is_at_edge=points >= contact.stick_half_width,
        )

    def densities_and_slip_at_middle(self, friction_states: Indices) -> tuple[Array, float]:
        """Extra slip of a contact if each of m points is in the given state: its density mu of flat
        punches at the points, (m,), and the slip at x = 0 [length].

        The slip w at the points and the shear r that it makes are linear in mu. So there is one
        equation for each point, and one for the resultant:

        - it sticks, state 0: w = 0;
        - it slips along `direction`, state 1, or the other way, -1: the shear comes to f p;
        - it is in the slip zone at the edge, whose shear is at f p already: r = 0;
        - int r dx = 0, since the loads do not change.
        """
        n_points = len(friction_states)
        is_sticking_point = friction_states == _STICKING
        # columns: mu at the points, then the slip at x = 0; rows: the points, then int r dx
        equations_matrix = np.zeros((n_points + 1, n_points + 1))
        equations_matrix[:n_points, :n_points] = np.where(
            is_sticking_point[:, None], self.slip_per_density, self.shear_per_density
        )
        equations_matrix[:n_points, n_points] = is_sticking_point
        equations_matrix[n_points, :n_points] = self.force_per_density
        # excess: |q| - f p in either sense of q [stress], which r must take away
        right_hand_side = np.zeros(n_points + 1)
        right_hand_side[:n_points] = np.where(
            friction_states == _SLIPPING, -self.direction * self.excess, 0.0
        )
        right_hand_side[:n_points] += np.where(
            (friction_states == _SLIPPING_BACK) & ~self.is_at_edge,
            self.direction * self.excess_of_reverse_slip,
            0.0,
        )
        *densities, slip_at_middle = np.linalg.solve(equations_matrix, right_hand_side)
        return np.array(densities), float(slip_at_middle)

    def corrected_states(
        self, friction_states: Indices, punch_densities: Array, slip_at_middle: float
    ) -> Indices:
        """Friction states of m points after a trial of the extra slip, with those changed that
        break Coulomb's law: 1 slips along `direction`, 0 sticks, -1 slips the other way.

        A slipping point that moves against its direction is made to stick. A sticking point whose
        |q| exceeds f p is made to slip in the direction of q. The trial gave the density mu of flat
        punches at the points, `punch_densities` (m,), and the slip at x = 0 [length]. Shear and
        slip at the points are linear in mu.
        """
        added_shear = self.direction * (self.shear_per_density @ punch_densities)
        added_slip = self.direction * (self.slip_per_density @ punch_densities + slip_at_middle)
        slip_roundoff = _ROUND_OFF_SHARE * float(np.max(np.abs(added_slip)))
        moves_back = (friction_states == _SLIPPING) & (added_slip < -slip_roundoff)
        moves_back |= (
            (friction_states == _SLIPPING_BACK) & (added_slip > slip_roundoff) & ~self.is_at_edge
        )
        new_states = np.where(moves_back, _STICKING, friction_states)
        is_sticking_point = friction_states == _STICKING
        # excess: |q| - f p by the memory curve, for either sense of q [stress]
        exceeds_limit = is_sticking_point & (self.excess + added_shear > self.excess_tolerance)
        new_states = np.where(exceeds_limit, _SLIPPING, new_states)
        exceeds_limit_of_reverse = is_sticking_point & (
            self.excess_of_reverse_slip - added_shear > self.excess_tolerance
        )
        return np.where(exceeds_limit_of_reverse, _SLIPPING_BACK, new_states)


def _slip_on_punches(
    contact: _MemoryContact, half_widths: Array, coarser_solution: InnerSlip | None
) -> InnerSlip | None:
    """Extra slip inside the contact that brings the shear down to |q| <= f p, as a superposition of
    flat punches of given half-widths (m + 1,). None if the search for its zone fails.

    Coulomb's law holds at m points, all half-widths but the last. In each trial every point has a
    state: 1 slips in the direction of the extra slip, 0 sticks, -1 slips the other way, as the edge
    does. The trial gives the density of the punches and the slip at x = 0. Points that break the
    law then change their state (active set), in 200 trials at most.

    Parameters
    ----------
    contact
        q and f p of the memory curve (tangential force carried up to each load) as a function of x;
        direction of the extra slip; E*
    half_widths
        of the punches [length]
    coarser_solution
        extra slip by fewer punches, whose zone is tried first; None: the points with |q| > f p
    """
    punch_problem = _PunchProblem.of_contact(contact, half_widths)
    friction_states = np.where(
        punch_problem.excess > punch_problem.excess_tolerance, _SLIPPING, _STICKING
    )
    if coarser_solution is not None:
        # those of the next smaller half-width
        friction_states = coarser_solution.friction_states[
            np.searchsorted(coarser_solution.half_widths, half_widths[:-1], side="right") - 1
        ]
    friction_states = np.where(punch_problem.is_at_edge, _SLIPPING_BACK, friction_states)

    for trial_number in range(_MOST_TRIALS):
        punch_densities, slip_at_middle = punch_problem.densities_and_slip_at_middle(
            friction_states
        )
        new_states = punch_problem.corrected_states(
            friction_states, punch_densities, slip_at_middle
        )
        changed_points = np.flatnonzero(new_states != friction_states)
        if not len(changed_points):
            return InnerSlip(
                contact.modulus,
                half_widths,
                punch_densities,
                slip_at_middle,
                contact.direction,
                friction_states,
            )
        # later trials change one point at a time
        if trial_number > _TRIALS_OF_ALL_POINTS:
            changed_points = changed_points[:1]
        friction_states[changed_points] = new_states[changed_points]
    return None
