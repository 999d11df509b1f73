"""Ciavarella-Jaeger superposition: normal contact as a sum of flat punches, all fields from P(a),
its inverse and its slope.

Between two half-planes every increment dP of the load adds the pressure dP/(pi sqrt(a^2 - x^2)) of
a flat punch of half-width a. So one law P(a) gives pressure, normal approach and what the
tangential problem needs (Ciavarella 1998, Jaeger 1998; in axisymmetric contact the sum of flat
punches goes by the name of Mossakovskii too):

    p(x, P)  = (1/pi) int_x^a g/sqrt(alpha^2 - x^2) d alpha             g = dP/d alpha
    S(x, P)  = int g arccosh(|x|/alpha) d alpha,  alpha < min(a, |x|)   displacement outside a punch
    Lam      = int_c^a g ln(alpha/c) d alpha                            kernel of the work W
    int ln(2 L/alpha) dP                                movement against a datum at distance L

# notation: a half-width, a_0 that of no load (0, or half the length of a flat), d = a - a_0 the
#           advance of the edge, alpha and delta the same of a punch within, P or eta normal load,
#           P_x load at which a = |x|, b a corner: dP/da is not smooth there

The laws are functions of the advance d, so that a contact that has hardly left a flat face keeps
its digits. The integrals are piecewise Chebyshev primitives in a variable v that takes the roots
away:

    pressure     delta = x - a_0 or b + |x - b| sinh^2 v
    outside      alpha = b + (x - b) sin^2 v        of W x/(alpha sqrt(x^2 - alpha^2)), by parts
    logarithm    alpha = b + v^2                    of W/alpha, by parts

with W = P, or P^2/2 for the moments, which have eta in front. Behind a corner g is a smooth
function of sqrt(alpha - b) only, and so are the integrands in v. A series that is not resolved is
halved; what its last coefficients are worth is the error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from scenes.array_types import Array
from scenes.chebyshev import (
    CHEBYSHEV_NODES,
    chebyshev_coefficients,
    clenshaw_values,
    truncation_error,
)
from semi_analytic.quadrature import gauss_rule, graded_nodes

Indices = NDArray[np.intp]
Function = Callable[[Array], Array]
IntegralKind = Literal["pressure", "outside", "logarithm"]

_EPS = float(np.finfo(float).eps)
# Octaves of the advance, below the largest, that have Chebyshev series of their own.
_OCTAVE_COUNT = 24
# Longest range of v that one Chebyshev series serves.
_LARGEST_PANEL_LENGTH = {"pressure": 1.2, "outside": 0.8, "logarithm": np.inf}
# |x - b| over the half-width that stands for 0: its logarithm is 55.
_LEAST_DISTANCE_RATIO = 1e-24
# A series is resolved where its last coefficients are at most this share of the integral.
_NEGLIGIBLE_COEFFICIENT_SHARE = 4e-15
# Halvings of a panel at most, and the ratio of last coefficients above which a halving gained
# nothing.
_MOST_HALVINGS = 12
_COEFFICIENT_RATIO_WITHOUT_GAIN = 0.9
# Panels that are integrated at a time, which bounds the memory.
_PANELS_AT_ONCE = 20_000
# Primitives of one integral that stay in the cache.
_CACHED_PRIMITIVES = 8
# Points that one primitive serves.
_POINTS_OF_PRIMITIVE = 4096
# Share of a^2 below which a difference of squares is taken from the rise of P; the same across
# several corners.
_CLOSE_SQUARE_SHARE = 0.01
_CLOSE_SQUARE_SHARE_ACROSS_CORNERS = 1e-6
# Gauss' nodes of an integral over loads between two corners.
_NODES_BETWEEN_CORNERS = 12
# Integrals over loads that are taken at a time, which bounds the memory.
_INTEGRALS_AT_ONCE = 4096
# Gauss' rule takes Lam where P - P_c is at most this share of P_c - P_b, P_b the load at the last
# corner.
_SHORT_LOAD_RANGE_SHARE = 0.3
# Share of P above which P - P_c is large enough for Lam to be a difference of two integrals.
_FAR_LOAD_SHARE = 0.02
# Round-offs that Lam has at most where it is a sum over nodes: of the sum, of the inverse a(P) and
# of the slope dP/da at each node.
_ROUND_OFFS_OF_KERNEL = 100


def as_floats(values: ArrayLike) -> Array:
    """Numbers as an array of floats."""
    return np.asarray(values, dtype=float)


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """P(a) of one profile between two given materials, as functions of the advance d = a - a_0 of
    the edge.

    Attributes
    ----------
    load, edge_advance, stiffness
        P(d), d(P) and dP/da(d), arrays of any shape; loads per unit thickness
    least_half_width
        a_0, the half-width of no load [length]
    corner_half_widths
        half-widths of the corners, ascending
    exponent
        n of P ~ d^n at small d
    extent
        largest half-width, where the profile ends
    half_width_may_be_steep
        whether P may hardly grow between corners, so that a(P) is all but steep there
    relative_roundoff
        relative error of P and dP/da themselves
    """

    load: Function
    edge_advance: Function
    stiffness: Function
    least_half_width: float = 0.0
    corner_half_widths: tuple[float, ...] = ()
    exponent: float = 2.0
    extent: float = np.inf
    half_width_may_be_steep: bool = False
    relative_roundoff: float = 2 * _EPS

    @cached_property
    def corner_advances(self) -> Array:
        """Advances d = a - a_0 at which the edge of contact is at a corner of the profile, 0 first,
        (n,) ascending [length].

        Behind each of them P and dP/da are smooth functions of the root of the distance from it.
        """
        return np.array([0.0, *(b - self.least_half_width for b in self.corner_half_widths)])

    @property
    def advance_ratio_of_series(self) -> float:
        """Ratio of advances that one Chebyshev series serves: 2, or less where P would fall by
        more than 2^3.
        """
        return float(2.0 ** min(1.0, 3.0 / self.exponent))


@dataclass(frozen=True, eq=False)
class PunchSuperposition:
    """Two half-planes pressed together by a profile of a given law. Methods take arrays that
    broadcast; loads per unit thickness.

    Attributes
    ----------
    law
        P(a)
    datum_length
        L, distance of the datum of rigid movements [length]
    """

    law: ContactLaw
    datum_length: float
    has_closed_form: ClassVar[bool] = False

    @property
    def least_half_width(self) -> float:
        """a for P = 0 [length]."""
        return self.law.least_half_width

    @property
    def corner_half_widths(self) -> tuple[float, ...]:
        """Half-widths at which dP/da is not smooth."""
        return self.law.corner_half_widths

    @property
    def half_width_may_be_steep(self) -> bool:
        """Whether P may hardly grow somewhere between the corners."""
        return self.law.half_width_may_be_steep

    @property
    def relative_roundoff(self) -> float:
        """Relative error of P(a) and dP/da themselves."""
        return self.law.relative_roundoff

    @property
    def extent(self) -> float:
        """Largest half-width: where the profile ends [length]."""
        return self.law.extent

    @cached_property
    def corner_loads(self) -> Array:
        """Loads at which the edge is at a corner, (n,) ascending."""
        return self.load(np.array(self.corner_half_widths, dtype=float))

    # --- the law of normal contact

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness], 0 below the least half-width."""
        return self.law.load(self._advance_to(half_width))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]. InputError for a load that needs a contact wider than the profile."""
        return self.least_half_width + self.law.edge_advance(as_floats(load))

    def edge_advance(self, load: ArrayLike) -> Array:
        """a(P) - a(0), with all its digits beside a flat too [length]."""
        return self.law.edge_advance(as_floats(load))

    def load_at(self, advance: ArrayLike) -> Array:
        """P from the advance a - a(0) of the edge of contact, the inverse of `edge_advance` [force
        per thickness].
        """
        return self.law.load(as_floats(advance))

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da >= 0 [stress]."""
        return self.law.stiffness(self._advance_to(half_width))

    @property
    def _is_sharp_wedge(self) -> bool:
        """Whether the profile is a wedge with a sharp tip, where the pressure is infinite."""
        return self.least_half_width == 0 and self.law.exponent <= 1

    def _advance_to(self, x: ArrayLike) -> Array:
        """Advance a - a_0 at which the edge of contact reaches |x| [length]; 0 for |x| < a_0, the
        half-width without load.
        """
        return np.maximum(np.abs(as_floats(x)) - self.least_half_width, 0.0)

    # --- fields of the normal problem

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Contact pressure p(x, P) >= 0 at the point x under the load P [stress], arrays that
        broadcast: 0 outside the contact, infinite at the tip of a sharp wedge.

        >>> from semi_analytic.profiles import law_of_power
        >>> contact = PunchSuperposition(
        ...     law_of_power(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(float(contact.pressure(0.6, np.pi / 4)), 12)  # (E*/2 R) sqrt(a^2 - x^2), a = 1
        0.4
        """
        # the pressure, but finite at the tip of a sharp wedge
        pressure = self.pressure_rise(x, load)
        if not self._is_sharp_wedge:
            return pressure
        is_tip = (as_floats(x) == 0) & (as_floats(load) > 0)
        return np.where(is_tip, np.inf, np.maximum(pressure, 0.0))

    def pressure_rise(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Contact pressure p(x, P) at the point x [stress], for differences between two loads.

        It differs from `pressure` at the tip of a sharp wedge alone, where p is infinite. There it
        is (g/pi) ln(a/L), of which only differences have a meaning. a is the contact half-width,
        g = dP/da, L the datum length. `_pressure_and_error` takes the exponent of the load in the
        integrand, here 0, then |x| and P.
        """
        pressure, _ = self._pressure_and_error(0, np.abs(as_floats(x)), as_floats(load))
        return pressure if self._is_sharp_wedge else np.maximum(pressure, 0.0)

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """First moment over the load of the pressure rise at x, int_0^P eta dp(x, eta)
        [stress * load]; eta is the load on the way to P.
        """
        # 1: the exponent of eta in the integrand
        moment, _ = self._pressure_and_error(1, np.abs(as_floats(x)), as_floats(load))
        return np.maximum(moment, 0.0)

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Slip integral S(x, P) = int arccosh(|x|/a(eta)) d eta over loads eta < min(P, P_x) [force
        per thickness]. (A/pi) S is the displacement of the surface at the middle of the contact
        minus that at x, so that it is h(x) inside the contact.

        a(eta) is the contact half-width under the load eta, P_x the load at which the edge of
        contact reaches x, A = 2/E*. First loading by Q = f (P - P_c) makes the slip (f A/pi) [S(x,
        P) - S(x, P_c)] outside the stick zone, P_c being the load at its edge. E* is the composite
        modulus, f the friction.

        >>> from semi_analytic.profiles import law_of_power
        >>> contact = PunchSuperposition(
        ...     law_of_power(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(
        ...     2 / np.pi * float(contact.slip_integral(0.6, contact.load(0.6))), 12
        ... )  # h = 0.6^2/2 at the edge of contact
        0.18
        """
        distance_from_middle = np.abs(as_floats(x))
        # 0: the exponent of eta in the integrand
        integral, _ = self._arccosh_integral_and_error(0, distance_from_middle, as_floats(load))
        return np.maximum(integral, 0.0)

    def slip_integral_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """First moment of the slip integral, int eta arccosh(|x|/a(eta)) d eta over loads
        eta < min(P, P_x) [(force per thickness)^2]. a(eta) is the contact half-width under the load
        eta, P_x the load at which the edge of contact reaches x.
        """
        distance_from_middle = np.abs(as_floats(x))
        # 1: the exponent of eta in the integrand
        moment, _ = self._arccosh_integral_and_error(1, distance_from_middle, as_floats(load))
        return np.maximum(moment, 0.0)

    def log_datum_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P)), L the datum length, at the load P; large and finite for a = 0, where it is
        multiplied by P = 0.
        """
        return self._log_datum_ratio(self.law.edge_advance(as_floats(load)))

    def approach_integral(self, load: ArrayLike) -> Array:
        """Integral int_0^P ln(2 L/a(eta)) d eta = P ln(2 L/a) + int_0^a P/alpha d alpha [force per
        thickness]; times A/pi it is the normal approach of the two half-planes.

        alpha is the half-width of a flat punch within. L is the distance of the datum of rigid
        movements, A = 2/E*, a(eta) the contact half-width under the load eta. `_log_datum_ratio` is
        ln(2 L/a) from a - a_0. E* is the composite modulus.

        >>> from semi_analytic.profiles import law_of_power
        >>> contact = PunchSuperposition(
        ...     law_of_power(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(
        ...     float(contact.approach_integral(np.pi / 4) * 4 / np.pi - np.log(2)), 12
        ... )  # a = 1 = L: ln 2 + 1/2
        0.5
        """
        loads = as_floats(load)
        # a - a_0, a_0 the half-width without load
        advance = self.law.edge_advance(loads)
        # int_0^a P/alpha d alpha; 0: the exponent of eta in int ln(2 L/a) d eta
        integral_of_load_per_width, _ = self._load_per_width_integral_and_error(0, advance)
        return loads * self._log_datum_ratio(advance) + integral_of_load_per_width

    def approach_moment(self, load: ArrayLike) -> Array:
        """First moment int_0^P eta ln(2 L/a(eta)) d eta = P^2 ln(2 L/a)/2 + int_0^a P^2/(2 alpha) d
        alpha [(force per thickness)^2]; L is the distance of the datum of rigid movements, a(eta)
        the contact half-width under the load eta.
        """
        loads = as_floats(load)
        # a - a_0, a_0 the half-width without load
        advance = self.law.edge_advance(loads)
        # int_0^a P^2/(2 alpha) d alpha; 1: the exponent of eta in int eta ln(2 L/a) d eta
        integral_of_half_square, _ = self._load_per_width_integral_and_error(1, advance)
        return loads * loads * self._log_datum_ratio(advance) / 2 + integral_of_half_square

    def _log_datum_ratio(self, advance: Array) -> Array:
        """ln(2 L/a) from the advance a - a_0 of the edge of contact beyond the half-width a_0
        without load. L is `datum_length`, the distance of the datum of rigid movements, a_0
        `least_half_width`, 0 without a flat.
        """
        if self.least_half_width > 0:
            return np.log(2 * self.datum_length / self.least_half_width) - np.log1p(
                advance / self.least_half_width
            )
        return np.log(2 * self.datum_length) - np.log(np.maximum(advance, np.finfo(float).tiny))

    # --- kernels between a load and a point, from differences of load that are free of cancellation

    def arccosh_ratio(
        self, x: ArrayLike, load_difference: ArrayLike, punch_advance: ArrayLike
    ) -> Array:
        """arccosh(|x|/a) of a point x outside a flat punch of half-width a(eta), with all its
        digits close to the punch; eta is the load under which the contact is as wide as the punch.

        It is arsinh(sqrt(x^2 - a^2)/a), and x^2 - a^2 is taken from the difference of loads. For
        a = 0 it is 0: there the value is multiplied by eta = 0.

        Parameters
        ----------
        x
            place of the point [length]
        load_difference
            P_x - eta >= 0, P_x the load at which the edge of contact reaches x [force per
            thickness]
        punch_advance
            a(eta) - a(0) [length]
        """
        # `_advance_to`: |x| - a(0), at least 0
        advance_to_x, load_differences, punch_advances = np.broadcast_arrays(
            self._advance_to(x), as_floats(load_difference), as_floats(punch_advance)
        )
        punch_half_width = punch_advances + self.least_half_width
        # x^2 - a^2, without cancellation
        difference_of_squares = self._difference_of_squares(
            punch_advances, np.maximum(advance_to_x, punch_advances), load_differences
        )
        return np.arcsinh(
            np.sqrt(difference_of_squares)
            / np.where(punch_half_width > 0, punch_half_width, np.inf)
        )

    def inverse_root(
        self, x: ArrayLike, load_difference: ArrayLike, punch_advance: ArrayLike
    ) -> Array:
        """1/sqrt(a^2 - x^2) [1/length] of a point x inside a flat punch of half-width a(eta): pi
        times the pressure of the punch per load. `least_half_width` is a(0). Where the root is 0
        the value is 0.

        Parameters
        ----------
        x
            place of the point [length]
        load_difference
            eta - P_x > 0, eta the load under which the contact is as wide as the punch, P_x that
            at which its edge reaches x [force per thickness]
        punch_advance
            a(eta) - a(0) [length]
        """
        distance_from_middle, load_differences, punch_advances = np.broadcast_arrays(
            np.abs(as_floats(x)), as_floats(load_difference), as_floats(punch_advance)
        )
        advance_to_x = np.minimum(distance_from_middle - self.least_half_width, punch_advances)
        # a^2 - x^2, without cancellation
        difference_of_squares = self._difference_of_squares(
            advance_to_x, punch_advances, load_differences
        )
        return 1 / np.sqrt(np.where(difference_of_squares > 0, difference_of_squares, np.inf))

    def _difference_of_squares(
        self, inner_advance: Array, outer_advance: Array, load_difference: Array
    ) -> Array:
        """Difference of the squares of two contact half-widths, outer minus inner, (n,) [length^2],
        without loss of digits where they are close.

        Squares are close where they differ by less than 1 % of the outer one. Their difference is
        then `load_difference` over the mean of dP/d(a^2) between the two. Elsewhere, and where the
        inner advance is negative, that of a point within a flat, the squares are subtracted. Across
        several corners of the profile that has more digits than the mean, unless the corners are
        next to each other: there squares are close only below 1e-6 of the outer one.

        Parameters
        ----------
        inner_advance, outer_advance
            a - a_0 of both, a_0 the half-width without load, `least_half_width` [length]
        load_difference
            P at the outer half-width minus P at the inner one [force per thickness]
        """
        # advances at which the edge of contact is at a corner, where dP/da is not smooth, ascending
        corner_advances = self.law.corner_advances
        difference_of_squares = np.array(
            (outer_advance - inner_advance)
            * (outer_advance + inner_advance + 2 * self.least_half_width)
        )
        n_corners_between = np.searchsorted(corner_advances, outer_advance) - np.searchsorted(
            corner_advances, inner_advance
        )
        # as a share of the outer square: 1e-6 across several corners, else 1 %
        largest_close_share = np.where(
            n_corners_between > 1, _CLOSE_SQUARE_SHARE_ACROSS_CORNERS, _CLOSE_SQUARE_SHARE
        )
        outer_square = np.square(outer_advance + self.least_half_width)
        are_close = (inner_advance >= 0) & (
            difference_of_squares < largest_close_share * outer_square
        )
        if np.any(are_close):
            # mean of dP/d(a^2) between the two
            load_rise_per_square = self._mean_load_rise_per_square(
                inner_advance[are_close], outer_advance[are_close]
            )
            difference_of_squares[are_close] = load_difference[are_close] / np.where(
                load_rise_per_square > 0, load_rise_per_square, np.inf
            )
        return difference_of_squares

    def _mean_load_rise_per_square(self, inner_advance: Array, outer_advance: Array) -> Array:
        """Mean of dP/d(a^2) between two contact half-widths that are close, (n,) [stress/length].

        Both are given by their advance a - a_0 beyond the half-width a_0 without load.
        `law.corner_advances`, 0 first, are those at which the edge is at a corner of the profile:
        dP/da is not smooth there. The range is cut at the first corner between the two; further
        ones are integrated across.

        The mean is the rise of P over the rise of a^2, each summed before and behind the corner.
        Half of each is summed, since the factor 2 drops out of the quotient. `law` is that of the
        profile, P as a function of the advance. Where neither P nor a^2 rises the mean is 0.
        """

        # A range of at least four last digits of the inner advance, so that there is a mean. At
        # advance 0 this adds nothing: an empty range gets the mean 0 below.
        end_advance = np.maximum(outer_advance, inner_advance * (1 + 4 * _EPS))
        corner_advances = self.law.corner_advances
        number_of_corner_below = np.searchsorted(corner_advances, inner_advance, side="right") - 1
        next_corner_advance = np.append(corner_advances, np.inf)[number_of_corner_below + 1]
        # Half the rises of P and of a^2 from the inner advance up to the next corner, or to the
        # outer advance if no corner lies between. They are integrated over the root of the distance
        # from the corner below: P is smooth in it.
        half_rise_of_load, half_rise_of_square = self._half_rises(
            inner_advance,
            np.minimum(next_corner_advance, end_advance),
            corner_advances[number_of_corner_below],
        )

        # the rises behind that corner, where the range goes on there
        crossing_range_numbers = np.flatnonzero(next_corner_advance < end_advance)
        half_rise_of_load_behind_corner, half_rise_of_square_behind_corner = self._half_rises(
            next_corner_advance[crossing_range_numbers],
            end_advance[crossing_range_numbers],
            corner_advances[number_of_corner_below[crossing_range_numbers] + 1],
        )
        half_rise_of_load[crossing_range_numbers] += half_rise_of_load_behind_corner
        half_rise_of_square[crossing_range_numbers] += half_rise_of_square_behind_corner
        return half_rise_of_load / np.where(half_rise_of_square > 0, half_rise_of_square, 1.0)

    def _half_rises(
        self, begin_advance: Array, end_advance: Array, corner_advance: Array
    ) -> tuple[Array, Array]:
        """Half the rise of the load P [force per thickness] and of a^2 [length^2] between two
        advances a - a_0 of the edge of contact, `begin_advance` and `end_advance`, (n,) each; their
        quotient is the mean of dP/d(a^2).

        Both are integrals over the advance d, of dP/da and of 2 a. P is smooth in r with d =
        `corner_advance` + r^2, where that is the last corner of the profile before the first
        advance: so Gauss' rule is taken in r. Half, because d changes by 2 r dr, and the factor
        2 is left out. a_0 is the half-width without load.
        """
        # six nodes on [0, 1]
        unit_nodes, unit_weights = gauss_rule(6)
        begin_root = np.sqrt(np.maximum(begin_advance - corner_advance, 0.0))
        root_length = np.sqrt(np.maximum(end_advance - corner_advance, 0.0)) - begin_root
        roots_at_nodes = begin_root[:, None] + root_length[:, None] * unit_nodes
        advance = corner_advance[:, None] + roots_at_nodes * roots_at_nodes
        weights = root_length[:, None] * unit_weights * roots_at_nodes
        half_rise_of_load = np.sum(weights * self.law.stiffness(advance), axis=1)
        half_rise_of_square = np.sum(weights * 2 * (advance + self.least_half_width), axis=1)
        return half_rise_of_load, half_rise_of_square

    # --- the kernel of the friction work

    def dissipation_kernel(self, load: ArrayLike, slip_zone_load: ArrayLike) -> Array:
        """Kernel of the friction work, Lam(P, P_c) = int_{P_c}^P ln(a(eta)/c) d eta [force per
        thickness]. It equals the integral of p(x, P) arccosh(|x|/c) over the slip zones c < |x| <
        a, p the pressure.

        The friction work is (f A/pi) int Lam dw over the slip, with w = +-Q - f P and A = 2/E*.
        a(eta) is the contact half-width under the load eta, c = a(P_c) that of stick.
        `load` is P, `slip_zone_load` is P - P_c, P_c the load at the stick edge; both broadcast.
        Lam is 0 where nothing slips.

        Far apart, Lam is P ln(a/c) minus int_c^a P/alpha d alpha over the half-widths alpha between
        c and a. Close together, that would lose digits: there it is int (P - eta) d ln(a(eta)). E*
        is the composite modulus.

        >>> from semi_analytic.profiles import law_of_power
        >>> contact = PunchSuperposition(
        ...     law_of_power(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(float(contact.dissipation_kernel(2.0, 1.0)), 12)  # ln 2 - 1/2
        0.19314718056
        """
        loads, loads_above_stick = np.broadcast_arrays(as_floats(load), as_floats(slip_zone_load))
        is_by_difference = self._takes_difference_of_integrals(loads, loads_above_stick)
        is_by_integral = ~is_by_difference & (loads_above_stick > 0)
        kernel = np.zeros(loads.shape)
        if np.any(is_by_difference):
            kernel[is_by_difference] = self._kernel_as_difference(
                loads[is_by_difference], loads_above_stick[is_by_difference]
            )
        if np.any(is_by_integral):
            kernel[is_by_integral] = self._kernel_as_integral(
                loads[is_by_integral], loads_above_stick[is_by_integral]
            )
        return kernel

    def _takes_difference_of_integrals(
        self, load: Array, load_above_stick: Array
    ) -> NDArray[np.bool_]:
        """Whether the kernel Lam(P, P_c) = int ln(a(eta)/c) d eta of the friction work is taken as
        a difference of two larger integrals, a boolean for each pair of loads.

        So it is where P - P_c is above 2 % of P, and too long for Gauss' rule. Elsewhere Lam is
        integrated as a sum of positive terms. Gauss' rule suits a range of loads without a corner
        of the profile. The range must be shorter than 0.3 times the difference of P_c and the load
        at the corner below.

        `load` is P, `load_above_stick` is P - P_c, P_c the load at the stick edge. a(eta) is the
        contact half-width under the load eta, c = a(P_c).
        """
        stick_edge_load = np.maximum(load - load_above_stick, 0.0)
        # `_corner_loads`: loads P at which the edge of contact is at a corner, 0 first
        number_of_corner_below = np.maximum(
            np.searchsorted(self._corner_loads, stick_edge_load, side="right") - 1, 0
        )
        next_corner_load = np.append(self._corner_loads, np.inf)[number_of_corner_below + 1]
        load_from_corner = stick_edge_load - self._corner_loads[number_of_corner_below]
        is_short_range = load_above_stick < _SHORT_LOAD_RANGE_SHARE * load_from_corner
        suits_gauss_rule = is_short_range & (load <= next_corner_load)
        is_far_from_stick = load_above_stick > _FAR_LOAD_SHARE * load
        if self.half_width_may_be_steep:
            # Twelve nodes would miss a half-width at which P hardly grows.
            suits_gauss_rule &= ~is_far_from_stick
        return np.asarray(~suits_gauss_rule & is_far_from_stick)

    def _log_width_ratio(self, load: Array, load_above_stick: Array) -> tuple[Array, Array, Array]:
        """ln(a/c) of contact half-width a(P) over stick half-width c = a(P_c), and the advances
        a - a_0 and c - a_0 of both edges beyond the half-width a_0 without load [length].

        `load` is P, `load_above_stick` is P - P_c, P_c the load at the stick edge. P_c is their
        difference, known to the last digit of P. It is taken as a quarter of that digit at least:
        for P_c = 0 the logarithm would be 700.
        """
        stick_edge_load = np.maximum(load - load_above_stick, _EPS / 4 * load)
        contact_advance, stick_advance = self.law.edge_advance(np.stack([load, stick_edge_load]))
        # the smallest floating-point number, in place of c = 0
        least_stick_half_width = np.finfo(float).tiny * np.maximum(contact_advance, 1.0)
        stick_half_width = np.maximum(self.least_half_width + stick_advance, least_stick_half_width)
        # a/c - 1
        relative_rise = (contact_advance - stick_advance) / stick_half_width
        return np.log1p(relative_rise), contact_advance, stick_advance

    def _kernel_as_difference(self, load: Array, load_above_stick: Array) -> Array:
        """Kernel Lam(P, P_c) of the friction work as P ln(a/c) - int_c^a P/alpha d alpha [force per
        thickness], alpha the half-widths between stick c and contact a. `load` is P,
        `load_above_stick` is P - P_c, P_c the load at the edge of stick.
        """
        # ln(a/c), a - a_0 and c - a_0, a_0 the half-width without load
        log_width_ratio, contact_advance, stick_advance = self._log_width_ratio(
            load, load_above_stick
        )
        # int_0^a P/alpha d alpha and the same up to c
        integrals_to_both_edges, _ = self._load_per_width_integral_and_error(
            0, np.stack([contact_advance, stick_advance])
        )
        integral_to_contact, integral_to_stick_edge = integrals_to_both_edges
        return load * log_width_ratio - (integral_to_contact - integral_to_stick_edge)

    def _kernel_as_integral(self, load: Array, load_above_stick: Array) -> Array:
        """Kernel Lam(P, P_c) of the friction work as the integral of (P - eta) d ln(a(eta)) over
        loads eta from P_c to P, a sum of positive terms, (n,) [force per thickness]. a(eta) is the
        contact half-width under the load eta.

        Each integral is cut where the edge of contact passes a corner of the profile. `load` is P,
        `load_above_stick` is P - P_c, P_c the load at the stick edge, (n,) each.
        """
        kernel = np.zeros(load.shape)
        stick_edge_load = load - load_above_stick
        # Numbers of corner loads, at which the edge of contact is at a corner of the profile, 0
        # first: of the first above P_c, and of the first that is not below P.
        first_corner_number = np.searchsorted(self._corner_loads, stick_edge_load, side="right")
        end_corner_number = np.maximum(
            np.searchsorted(self._corner_loads, load, side="left"), first_corner_number
        )
        # parts of each integral, from corner to corner
        n_parts = end_corner_number - first_corner_number + 1
        # 4096 integrals at once bound the memory.
        chunk_ends = np.arange(_INTEGRALS_AT_ONCE, len(load), _INTEGRALS_AT_ONCE)
        for integral_numbers in np.split(np.arange(len(load)), chunk_ends):
            n_parts_in_chunk = n_parts[integral_numbers]
            # of each part: the integral it belongs to, its number there, and the corner behind
            # which it lies
            integral_number_of_part = np.repeat(integral_numbers, n_parts_in_chunk)
            first_part_number_of_integral = np.cumsum(n_parts_in_chunk) - n_parts_in_chunk
            part_number_in_integral = np.arange(len(integral_number_of_part)) - np.repeat(
                first_part_number_of_integral, n_parts_in_chunk
            )
            number_of_corner_below = (
                part_number_in_integral + first_corner_number[integral_number_of_part] - 1
            )
            integrals_of_parts = self._integrals_of_parts(
                load[integral_number_of_part],
                load_above_stick[integral_number_of_part],
                number_of_corner_below,
            )
            kernel += np.bincount(integral_number_of_part, integrals_of_parts, len(kernel))
        return kernel

    def _integrals_of_parts(
        self, load: Array, load_above_stick: Array, number_of_corner_below: Indices
    ) -> Array:
        """Integrals of (P - eta) d ln(a(eta)) over loads eta between two corners of the profile,
        (n,) [force per thickness]: the parts of the kernel Lam(P, P_c) of the friction work.

        A part begins at P_c, or at the load P_b of its corner if that is larger. It ends at P, or
        at the load of the next corner. a(eta), the contact half-width under the load eta, is a
        smooth function of sqrt(eta - P_b), and Gauss' rule in that root is accurate. P_c is the
        load at the stick edge. Close to no load a goes as any power of eta: there a rule for
        singular ends is used.

        Parameters
        ----------
        load
            P [force per thickness]
        load_above_stick
            P - P_c, which has more digits than the difference of both
        number_of_corner_below
            number of the part's corner in `_corner_loads`, the loads P at which the edge of contact
            is at a corner, 0 first
        """
        corner_loads = np.append(self._corner_loads, np.inf)
        stick_edge_load = load - load_above_stick
        next_corner_load = corner_loads[number_of_corner_below + 1]
        begin_load = np.maximum(stick_edge_load, corner_loads[number_of_corner_below])
        end_load = np.minimum(load, next_corner_load)
        # A range up to P is what is left of P - P_c, whose digits a difference of loads would lose.
        load_above_begin = np.maximum(load_above_stick - (begin_load - stick_edge_load), 0.0)
        load_range = np.where(next_corner_load >= load, load_above_begin, end_load - begin_load)
        integrals = np.zeros(len(load))

        # behind a corner, or far from no load: a range below 0.3 of the load at its start
        suits_gauss_rule = (number_of_corner_below > 0) | (
            load_range < _SHORT_LOAD_RANGE_SHARE * begin_load
        )
        for takes_gauss_rule in (True, False):
            uses_rule = suits_gauss_rule == takes_gauss_rule
            if not np.any(uses_rule):
                continue
            begin_column = begin_load[uses_rule, None]
            range_column = load_range[uses_rule, None]
            # nodes, as eta minus the load at the start of the part, and weights, (parts, nodes)
            if takes_gauss_rule:
                corner_column = corner_loads[number_of_corner_below[uses_rule], None]
                load_above_corner = begin_column - corner_column
                loads_from_begin, weights = _nodes_in_root(load_above_corner, range_column)
            else:
                loads_from_begin, weights = (
                    nodes_or_weights[:, 0] for nodes_or_weights in graded_nodes(0.0, range_column)
                )
            # P - eta from P - P_c, which keeps its digits
            load_above_node = load_above_stick[uses_rule, None] - (
                (begin_column - stick_edge_load[uses_rule, None]) + loads_from_begin
            )
            # d ln(a) is d eta over the stiffness d eta/d ln(a)
            log_stiffness = self._log_stiffness(begin_column + loads_from_begin)
            integrand = load_above_node / np.where(log_stiffness > 0, log_stiffness, np.inf)
            integrals[uses_rule] = np.sum(weights * integrand, axis=-1)
        return integrals

    def _log_stiffness(self, load: Array) -> Array:
        """dP/d ln(a) = a dP/da of the contact under loads of any shape [force per thickness], a its
        half-width. `least_half_width` is a without load; `law` is that of the advance of a beyond
        it.
        """
        advance = self.law.edge_advance(load)
        return (self.least_half_width + advance) * self.law.stiffness(advance)

    # --- errors

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Estimated error of the values that the method called `name` returns for these arguments,
        in their units; not below the true error.

        The error is the sum of three:

        - what the Chebyshev series leave out;
        - what the last digit of a half-width changes;
        - the error of P(a) itself, and fifty round-offs.

        Parameters
        ----------
        name
            "pressure", "pressure_moment", "slip_integral", "slip_integral_moment",
            "approach_integral", "approach_moment" or "dissipation_kernel"
        arguments
            those of the method: x and P of a field at points, P of "approach_...". Of
            "dissipation_kernel" P and P - P_c, P_c the load at the stick edge.
        """
        argument_arrays = np.broadcast_arrays(*(as_floats(argument) for argument in arguments))
        if name == "dissipation_kernel":
            return self._error_of_dissipation_kernel(*argument_arrays)
        # 1 for moments, where the load stands in front of the integrand
        load_power = int(name.endswith("_moment"))
        load = argument_arrays[-1]
        # half-width without load, and how far the edge has advanced from there
        half_width = self.least_half_width + self.law.edge_advance(load)
        # The first argument is x of "pressure" and "slip_integral", P of "approach_integral".
        value, series_error, sensitive_length = self._value_error_and_sensitive_length(
            name.removesuffix("_moment"), load_power, argument_arrays[0], load
        )
        # The value changes by about the same share as this length: by eight round-offs of the
        # half-width over it.
        least_length = _EPS * np.maximum(half_width, np.finfo(float).tiny)
        relative_last_digit = 8 * _EPS * half_width / np.maximum(sensitive_length, least_length)
        relative_error = relative_last_digit + self.relative_roundoff + 50 * _EPS
        return series_error + relative_error * np.abs(value)

    def _value_error_and_sensitive_length(
        self, method_name: str, load_power: int, point_or_load: Array, load: Array
    ) -> tuple[Array, Array, Array]:
        """Value of an integral over flat punches, the error of its Chebyshev series, and a length
        by which the error from round-off of a half-width is estimated.

        The value changes by about the same share as this sensitive length. It is

        - of "pressure" the distance from x to the edge of contact;
        - of "slip_integral" the smaller of half-width and |x|, minus `least_half_width`, the
          half-width without load;
        - of "approach_integral" the half-width.

        Parameters
        ----------
        method_name
            "pressure", "slip_integral" or "approach_integral"
        load_power
            1 where the load stands in front of the integrand, else 0
        point_or_load, load
            x for the first two methods, P for the last; and P [force per thickness]; arrays of one
            shape
        """
        advance = self.law.edge_advance(load)
        half_width = self.least_half_width + advance
        if method_name == "pressure":
            distance_from_middle = np.abs(point_or_load)
            value, error = self._pressure_and_error(load_power, distance_from_middle, load)
            error = error + self._pressure_change_by_last_digit(
                load_power, distance_from_middle, advance
            )
            return value, error, np.abs(half_width - distance_from_middle)
        if method_name == "slip_integral":
            distance_from_middle = np.abs(point_or_load)
            value, error = self._arccosh_integral_and_error(load_power, distance_from_middle, load)
            return (
                value,
                error,
                np.minimum(half_width, distance_from_middle) - self.least_half_width,
            )
        value, error = self._load_per_width_integral_and_error(load_power, advance)
        value = value + np.abs(load) ** (1 + load_power) * np.abs(self._log_datum_ratio(advance))
        return value, error, half_width

    def _error_of_dissipation_kernel(self, load: Array, load_above_stick: Array) -> Array:
        """Estimated error of the kernel of friction work Lam(P, P_c) = int ln(a(eta)/c) d eta, not
        below the true one [force per thickness]; `load` is P, `load_above_stick` is P - P_c. P_c is
        the load at the stick edge, c its half-width, alpha a half-width between c and a.

        Integrated as a sum of positive terms Lam has some round-offs of itself. As the difference
        P ln(a/c) - int P/alpha d alpha it has round-offs of both terms, and what the Chebyshev
        series of the integral leaves out.
        """
        kernel = self.dissipation_kernel(load, load_above_stick)
        log_width_ratio, contact_advance, _ = self._log_width_ratio(load, load_above_stick)
        # int_0^a P/alpha d alpha and the error of its Chebyshev series
        integral_to_contact, series_error = self._load_per_width_integral_and_error(
            0, contact_advance
        )
        size_of_terms = load * log_width_ratio + np.abs(integral_to_contact)
        error_of_difference = series_error + (8 * _EPS + self.relative_roundoff) * size_of_terms
        # 0 where the kernel is not taken as that difference
        is_difference = self._takes_difference_of_integrals(load, load_above_stick)
        error_of_difference = np.where(is_difference, error_of_difference, 0.0)
        # a hundred round-offs of the kernel itself, and that of P(a)
        return (
            error_of_difference + (_ROUND_OFFS_OF_KERNEL * _EPS + self.relative_roundoff) * kernel
        )

    def _pressure_change_by_last_digit(
        self, load_power: int, distance_from_middle: Array, advance: Array
    ) -> Array:
        """Change of the pressure at |x| = `distance_from_middle` [stress] by the round-off of its
        substitution variable v; arrays of one shape. The pressure is an integral over flat punches,

            p = (1/pi) int_|x|^a eta^k g / sqrt(alpha^2 - x^2) d alpha,    g = d eta/d alpha

        alpha is the half-width of a punch, eta the normal load up to it, k = 0 (1 for moments). The
        integral is a Chebyshev series in v, next to x with alpha = |x| + |x - b| sinh^2 v, b the
        nearest corner of the profile (the advances of all are `law.corner_advances`, 0 among them).
        So the edge of contact is |x - b| sinh^2 v beyond x.

        `law.stiffness` is g as a function of the advance, `law.load` P. With eps the round-off of
        numbers, a change of v by eps v moves the edge by 2 eps v (a - |x|), and p by dp/da times
        that. At x = 0 v reaches 28, and p of a profile |x|^n goes as a^(n - 1): for |x|^20 the
        change is 2e-13 of p.

        Parameters
        ----------
        load_power
            k, 0 or 1, the power of the load eta in the integrand; with 1 the result is in
            stress times force per thickness
        advance
            a - a_0 of the edge, a_0 the half-width without load, `least_half_width` [length]
        """
        half_width = self.least_half_width + advance
        distance_to_edge = np.maximum(half_width - distance_from_middle, 0.0)
        root_ratio = np.sqrt(
            distance_to_edge / np.where(half_width > 0, half_width + distance_from_middle, np.inf)
        )
        # dp/da = g/(pi sqrt(a^2 - x^2)) at the edge, g = dP/da, times a - |x|
        change_per_relative_distance = self.law.stiffness(advance) * root_ratio / np.pi
        if load_power:
            change_per_relative_distance = change_per_relative_distance * self.law.load(advance)

        # |x - b|, at least 1e-24 of the advance
        advance_to_x = distance_from_middle - self.least_half_width
        distance_to_corners = np.abs(advance_to_x[..., None] - self.law.corner_advances)
        distance_to_corner = np.maximum(
            np.min(distance_to_corners, axis=-1), _LEAST_DISTANCE_RATIO * advance
        )
        v = np.arcsinh(
            np.sqrt(distance_to_edge / np.where(distance_to_corner > 0, distance_to_corner, np.inf))
        )
        return 2 * _EPS * v * change_per_relative_distance

    # --- the integrals

    @cached_property
    def _corner_loads(self) -> Array:
        """Loads P at which the edge of contact is at a corner of the profile, 0 first, (n,)
        ascending.
        """
        return self.law.load(self.law.corner_advances)

    @cached_property
    def _primitives(self) -> dict[tuple[IntegralKind, int], list[Primitive]]:
        """Cache of the primitives of earlier calls, by integral and power of the load."""
        return {}

    def _integral_and_error(
        self, kind: IntegralKind, load_power: int, x: Array, advance: Array
    ) -> tuple[Array, Array]:
        """An integral over flat punches at points `x`, from no load up to an `advance` a - a_0 of
        the edge of contact, and its error; `x` and `advance` broadcast. Integral and error are 0
        for an advance of 0; a_0 is the half-width without load.

        `kind` names the integral: "pressure", "outside" (of arccosh, for a point outside the
        punches) or "logarithm". With `load_power` 1 the load eta stands in front of the integrand.
        A primitive, the integral as a function of its upper end, keeps its digits over a limited
        ratio of advances. Where these are wider apart they are grouped into bands, each within that
        ratio, and integrated band by band.
        """
        has_contact = advance > 0
        if not np.any(has_contact) or not np.size(x):
            zeros = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(advance)))
            return zeros, zeros
        largest_advance = float(np.max(advance))
        least_advance = float(np.min(advance, where=has_contact, initial=np.inf))
        # _advance_ratio_of_primitive: the ratio of advances that one primitive serves
        if largest_advance < least_advance * self._advance_ratio_of_primitive:
            return self._integral_and_error_in_band(kind, load_power, x, advance)
        broadcast_x, broadcast_advance = np.broadcast_arrays(x, advance)
        # Bands are numbered from the largest advance down; -1 where there is no contact.
        band_numbers = np.full(broadcast_advance.shape, -1)
        ratio_to_largest_advance = largest_advance / broadcast_advance[broadcast_advance > 0]
        band_numbers[broadcast_advance > 0] = np.log(ratio_to_largest_advance) / math.log(
            self._advance_ratio_of_primitive
        )
        integral = np.zeros(broadcast_advance.shape)
        error = np.zeros(broadcast_advance.shape)
        for band_number in range(int(band_numbers.max()) + 1):
            is_in_band = band_numbers == band_number
            if np.any(is_in_band):
                integral[is_in_band], error[is_in_band] = self._integral_and_error_in_band(
                    kind, load_power, broadcast_x[is_in_band], broadcast_advance[is_in_band]
                )
        return integral, error

    @property
    def _advance_ratio_of_primitive(self) -> float:
        """Ratio of the largest to the least advance that one primitive serves with all its
        digits.
        """
        return float(self.law.advance_ratio_of_series ** (_OCTAVE_COUNT // 2))

    def _integral_and_error_in_band(
        self, kind: IntegralKind, load_power: int, x: Array, advance: Array
    ) -> tuple[Array, Array]:
        """An integral over flat punches at points `x`, up to the `advance` a - a_0 of the edge of
        contact, and its error. `x` and `advance` broadcast; an advance may be 0. a_0 is the
        half-width without load.

        The advances are those of one band: their ratio is small enough for one stored primitive,
        the integral as a function of the advance. `kind` names the integral, "pressure", "outside"
        or "logarithm"; with `load_power` 1 the load eta stands in front of the integrand.
        """
        # every different x once, ascending, and for each point the number of its x
        unique_x, number_in_unique_x = np.unique(np.ravel(x), return_inverse=True)
        number_in_unique_x = number_in_unique_x.reshape(np.shape(x))
        # A primitive takes some kilobytes a point: above 4096 different points they are taken in
        # chunks. Points that come back at many instants count once.
        if len(unique_x) > _POINTS_OF_PRIMITIVE:
            broadcast_x, broadcast_advance, broadcast_numbers_in_unique_x = np.broadcast_arrays(
                x, advance, number_in_unique_x
            )
            integral = np.zeros(broadcast_x.shape)
            error = np.zeros(broadcast_x.shape)
            for first_number in range(0, len(unique_x), _POINTS_OF_PRIMITIVE):
                is_in_chunk = (broadcast_numbers_in_unique_x >= first_number) & (
                    broadcast_numbers_in_unique_x < first_number + _POINTS_OF_PRIMITIVE
                )
                integral[is_in_chunk], error[is_in_chunk] = self._integral_and_error(
                    kind, load_power, broadcast_x[is_in_chunk], broadcast_advance[is_in_chunk]
                )
            return integral, error

        # the primitive from the cache, and the number of each x in it
        primitive, number_in_primitive = self._cached_primitive(
            kind, load_power, unique_x, float(np.max(advance))
        )
        point_number = number_in_primitive[number_in_unique_x]
        # the integral at these points up to the advance, and its error
        return primitive(*np.broadcast_arrays(point_number, advance))

    def _cached_primitive(
        self, kind: IntegralKind, load_power: int, x: Array, largest_advance: float
    ) -> tuple[Primitive, Indices]:
        """A primitive of an integral over flat punches from the cache, made where none of the last
        eight (_CACHED_PRIMITIVES) of this `kind` and `load_power` serves; with the numbers that the
        points `x` have in it, (k,).

        A primitive is the integral at all its points as a function of its upper end. It keeps its
        points `x`, ascending, and its own `largest_advance`. The cache `_primitives` has a list for
        each `kind` and `load_power`, the latest first.

        Parameters
        ----------
        kind, load_power
            which integral ("pressure", "outside", "logarithm"); with 1 the load stands in front of
            the integrand
        x
            (k,) distances |x| of the points [length], ascending
        largest_advance
            largest upper end, a - a_0 of the edge of contact, a_0 the half-width without load
            [length]
        """
        cached_primitives = self._primitives.setdefault((kind, load_power), [])
        # A primitive that goes up to `advance_limit`, or beyond, would lose digits of these
        # advances. _advance_ratio_of_primitive: the ratio of advances that it serves with all
        # digits
        advance_limit = largest_advance * self._advance_ratio_of_primitive
        for primitive in cached_primitives:
            point_numbers = np.minimum(np.searchsorted(primitive.x, x), len(primitive.x) - 1)
            has_suitable_range = largest_advance <= primitive.largest_advance < advance_limit
            if has_suitable_range and np.array_equal(primitive.x[point_numbers], x):
                return primitive, point_numbers
        # none serves: a new one, `law` being P(a) of the profile
        primitive = primitive_of(kind, load_power, x, largest_advance, self.law)
        cached_primitives[:] = [primitive, *cached_primitives[: _CACHED_PRIMITIVES - 1]]
        return primitive, np.arange(len(x))

    def _pressure_and_error(
        self, load_power: int, distance_from_middle: Array, load: Array
    ) -> tuple[Array, Array]:
        """Contact pressure at |x| = `distance_from_middle` under a load, and its error [stress]:
        int g/(pi sqrt(alpha^2 - x^2)) d alpha over the flat punches that reach beyond x.

        alpha is the half-width of a punch, g = dP/d alpha its load per half-width. With
        `load_power` 1 the load eta stands in front of g. `law.edge_advance` is a minus
        `least_half_width`, the half-width without load; `law.stiffness` is g as a function of it.
        At the tip of a sharp wedge the integral is infinite. In its place stands (g/pi) ln(a/L), L
        the `datum_length`, of which only differences have a meaning.
        """
        # half-width a under the load, minus that without load
        advance = self.law.edge_advance(load)
        is_inside_contact = distance_from_middle < self.least_half_width + advance
        pressure, error = self._integral_and_error(
            "pressure", load_power, distance_from_middle, np.where(is_inside_contact, advance, 0.0)
        )
        pressure = np.where(is_inside_contact & (advance > 0), pressure, 0.0)
        if self._is_sharp_wedge and load_power == 0:
            with np.errstate(divide="ignore"):
                pressure_at_tip = (
                    self.law.stiffness(np.zeros(())) / np.pi * np.log(advance / self.datum_length)
                )
            pressure = np.where(distance_from_middle == 0, pressure_at_tip, pressure)
        return pressure, error

    def _arccosh_integral_and_error(
        self, load_power: int, distance_from_middle: Array, load: Array
    ) -> tuple[Array, Array]:
        """Integral of arccosh(|x|/alpha) dP over the flat punches of half-width alpha < |x| =
        `distance_from_middle` up to a load, and its error [force per thickness].

        By parts it is int W x/(alpha sqrt(x^2 - alpha^2)) d alpha plus W arccosh(|x|/alpha) at the
        upper end, the smaller of a and |x|. W = P; with `load_power` 1, where the load stands in
        front, W = P^2/2. Advances are half-widths minus `least_half_width`, that without load;
        `law.edge_advance` is that of a load, `_advance_to` that at which the edge reaches x.
        """
        advance = self.law.edge_advance(load)
        advance_to_x = self._advance_to(distance_from_middle)
        end_advance = np.minimum(advance, advance_to_x)
        # the integral by parts, without the term at the upper end
        integral, error = self._integral_and_error(
            "outside", load_power, distance_from_middle, end_advance
        )
        end_load = np.minimum(load, self.law.load(advance_to_x))
        end_half_width = end_advance + self.least_half_width
        # sqrt(x^2 - alpha^2) without cancellation
        root_of_squares = np.sqrt(
            (advance_to_x - end_advance) * (advance_to_x + end_advance + 2 * self.least_half_width)
        )
        arccosh = np.arcsinh(root_of_squares / np.where(end_half_width > 0, end_half_width, np.inf))
        # _integral_of_load_power: W of a load
        return integral + _integral_of_load_power(load_power, end_load) * arccosh, error

    def _load_per_width_integral_and_error(
        self, load_power: int, advance: Array
    ) -> tuple[Array, Array]:
        """Integral int_0^a P/alpha d alpha over the half-widths alpha of flat punches up to that
        with this `advance` a - a_0, and its error [force per thickness], shape of `advance`; a_0 is
        the half-width without load.

        With `load_power` 1 it is int_0^a P^2/(2 alpha) d alpha [(force per thickness)^2].
        """
        # the integral does not depend on a point: one point, 0, for all
        integral, error = self._integral_and_error(
            "logarithm", load_power, np.zeros(1), advance.reshape(-1, 1)
        )
        return integral.reshape(advance.shape), error.reshape(advance.shape)


@dataclass(frozen=True, eq=False)
class Panels:
    """Ranges [begin_v, end_v] of the integration variable v, n of them, on each of which one
    Chebyshev series serves; (n,) each. v takes the roots out of the integrands.

    Attributes
    ----------
    point_number, x
        number of the point that a panel belongs to, and its |x| [length]
    advance_at_v0
        advance d = a - a_0 of the edge of contact at v = 0 [length]
    scale
        factor of v: sqrt(|x - b|), b the corner of the profile behind which the panel lies; or 1
    begin_v, end_v
        the ends of the panel
    """

    point_number: Indices
    x: Array
    advance_at_v0: Array
    scale: Array
    begin_v: Array
    end_v: Array

    @classmethod
    def joined(cls, parts: Sequence[Panels]) -> Panels:
        """The panels of all parts, one after the other."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return cls(*(np.concatenate(column) for column in columns))

    def take(self, numbers: Indices) -> Panels:
        """The panels with these numbers."""
        return Panels(*(values[numbers] for values in vars(self).values()))

    def cut_to(self, largest_length: float) -> Panels:
        """Each panel cut into as few equal parts as are not longer than `largest_length`, in order.

        A panel is a range of the integration variable v that one Chebyshev series serves. The last
        part of a panel ends exactly where the panel did. `begin_v` and `end_v` (n,) are the ends of
        the panels in v.
        """
        n_parts = np.maximum(np.ceil((self.end_v - self.begin_v) / largest_length), 1).astype(int)
        panel_number_of_part = np.repeat(np.arange(len(n_parts)), n_parts)
        first_part_number_of_panel = np.cumsum(n_parts) - n_parts
        part_number_in_panel = np.arange(len(panel_number_of_part)) - np.repeat(
            first_part_number_of_panel, n_parts
        )
        part_length = ((self.end_v - self.begin_v) / n_parts)[panel_number_of_part]
        # for each part, the panel it is cut from
        uncut_panels = self.take(panel_number_of_part)
        begin_v = uncut_panels.begin_v + part_number_in_panel * part_length
        is_last_part_of_panel = part_number_in_panel == n_parts[panel_number_of_part] - 1
        end_v = np.where(is_last_part_of_panel, uncut_panels.end_v, begin_v + part_length)
        return replace(uncut_panels, begin_v=begin_v, end_v=end_v)

    def halved(self) -> Panels:
        """Both halves of each panel: the lower halves of all, then the upper ones."""
        middle_v = (self.begin_v + self.end_v) / 2
        lower_half = replace(self, end_v=middle_v)
        upper_half = replace(self, begin_v=middle_v)
        return Panels.joined([lower_half, upper_half])

    def advance_beyond_v0(self, kind: IntegralKind, v: Array) -> Array:
        """Advance of the edge of contact from its place at v = 0 to that at v, (n,) or (n, nodes)
        as v [length]. `kind` names the integral: "pressure", "outside" or "logarithm". `scale` (n,)
        is the factor of v of each panel.
        """
        scale = self.scale.reshape(-1, *[1] * (v.ndim - 1))
        if kind == "pressure":
            return np.square(scale * np.sinh(v))
        return np.square(scale * np.sin(v) if kind == "outside" else v)


@dataclass(frozen=True, eq=False)
class Primitive:
    """An integral over flat punches at points `x` (k,), ascending, as a function of its upper end,
    the advance d = a - a_0 of the edge of contact up to `largest_advance`.

    Attributes
    ----------
    kind
        which integral: "pressure", "outside" (of arccosh) or "logarithm"
    distance_beyond_flat
        (k,) x - a_0 [length]
    panels
        the n ranges of the variable v on which one Chebyshev series each holds
    begin_advances
        (n,) advance at the start of each panel [length]
    coefficients
        (m, n) of the Chebyshev series of the integral on each panel
    error
        (n,) error of the integral at the end of each panel, by what its series leave out
    """

    kind: IntegralKind
    x: Array
    distance_beyond_flat: Array
    largest_advance: float
    panels: Panels
    begin_advances: Array
    coefficients: Array
    error: Array

    def __call__(self, point_number: Indices, advance: Array) -> tuple[Array, Array]:
        """The integral over flat punches from no load up to `advance` of the edge of contact, at
        the points with these numbers, and its error; arrays of one shape.

        Each point has panels: ranges of the integration variable v, each with one Chebyshev series
        of the integral. The panel that holds the advance is looked up, and its series is evaluated
        at the v of the advance.
        """
        panels = self.panels
        # The panel by one search for all: keys sort by point, then by advance at their start.
        rank_of_advance = np.searchsorted(self._sorted_begin_advances, advance, side="right")
        key = self._key(point_number, rank_of_advance)
        panel_number = np.searchsorted(self._panel_keys, key, side="right") - 1
        # Below the first panel of a point its integral is still 0.
        first_panel_number_of_point = np.searchsorted(panels.point_number, point_number)
        panel_number = np.maximum(panel_number, first_panel_number_of_point)
        v = _integration_variable(
            self.kind,
            advance,
            self.distance_beyond_flat[point_number],
            panels.advance_at_v0[panel_number],
            panels.scale[panel_number],
        )
        begin_v = panels.begin_v[panel_number]
        end_v = panels.end_v[panel_number]
        place_in_panel = np.clip((2 * v - begin_v - end_v) / (end_v - begin_v), -1.0, 1.0)
        integral = clenshaw_values(self.coefficients, panel_number, place_in_panel)
        return integral, self.error[panel_number]

    @cached_property
    def _sorted_begin_advances(self) -> Array:
        """Every advance at which some panel begins, ascending."""
        return np.unique(self.begin_advances)

    @cached_property
    def _panel_keys(self) -> Indices:
        """Key of each panel, ascending (n,): by its point, then by the advance at its start."""
        rank_of_advance = np.searchsorted(
            self._sorted_begin_advances, self.begin_advances, side="right"
        )
        return self._key(self.panels.point_number, rank_of_advance)

    def _key(self, point_number: Indices, rank_of_advance: Indices) -> Indices:
        """One integer from the number of a point and the rank of an advance, which sorts by the
        point first. A sum of x and the advance themselves would lose the digits of one.
        """
        return point_number * (len(self._sorted_begin_advances) + 1) + rank_of_advance


def _integration_variable(
    kind: IntegralKind,
    advance: Array,
    distance_beyond_flat: Array,
    advance_at_v0: Array,
    scale: Array,
) -> Array:
    """The integration variable v >= 0 that makes an integrand over flat punches smooth, from the
    advance d of their edge; arrays of one shape.

        pressure     d = d0 + scale^2 sinh^2 v
        outside      d = d0 + scale^2 sin^2 v       scale^2 = x - a_0 - d0
        logarithm    d = d0 + v^2

    d0 = `advance_at_v0`; d = a - a_0 is counted from the half-width a_0 without load [length].
    `distance_beyond_flat` is x - a_0 of the point. The `kind` of the integral selects the formula.
    """
    root_of_distance = np.sqrt(np.maximum(advance - advance_at_v0, 0.0))
    if kind == "pressure":
        return np.arcsinh(root_of_distance / scale)
    if kind == "outside":
        root_left_to_x = np.sqrt(np.maximum(distance_beyond_flat - advance, 0.0))
        return np.arctan2(root_of_distance, root_left_to_x)
    return root_of_distance


def _nodes_in_root(begin_distance: Array, span: Array) -> tuple[Array, Array]:
    """Gauss' nodes and weights for integrands that are smooth in the root of the distance from a
    corner of the profile: distances of the nodes from the start of each span, and weights.

    Both are (n, nodes), for n spans of integration. A span begins at `begin_distance` (n, 1) beyond
    its corner and has the length `span` (n, 1).
    """
    # twelve nodes on [0, 1]
    unit_nodes, unit_weights = gauss_rule(_NODES_BETWEEN_CORNERS)
    begin_root = np.sqrt(begin_distance)
    # sqrt(distance) at the end of the span minus that at its start; 0 for a span without length
    root_range = span / np.where(
        span > 0, begin_root + np.sqrt(begin_root * begin_root + span), 1.0
    )
    distances_from_begin = root_range * unit_nodes * (2 * begin_root + root_range * unit_nodes)
    weights = 2 * root_range * unit_weights * (begin_root + root_range * unit_nodes)
    return distances_from_begin, weights


def _integral_of_load_power(load_power: int, load: Array) -> Array:
    """W, the integral of eta^n over the load eta from 0 to `load`, n = `load_power`: P for 0, P^2/2
    for 1, that of moments.
    """
    return load * load / 2 if load_power else load


class _PanelSeries(NamedTuple):
    """Chebyshev series of an integrand on n panels: the panels, the coefficients (n, nodes) and an
    error (n,) of each integral, by what the last coefficients are worth.
    """

    panels: Panels
    coefficients: Array
    truncation_errors: Array

    def take(self, numbers: Indices) -> _PanelSeries:
        """The series on the panels with these numbers."""
        return _PanelSeries(
            self.panels.take(numbers), self.coefficients[numbers], self.truncation_errors[numbers]
        )

    def in_order_of_points(self) -> _PanelSeries:
        """The series with their panels in the order of the points that they belong to, and of each
        point outwards, by growing advance of the edge of contact.
        """
        panels = self.panels
        return self.take(np.lexsort((panels.begin_v, panels.advance_at_v0, panels.point_number)))

    @classmethod
    def joined(cls, parts: list[_PanelSeries]) -> _PanelSeries:
        """The series of all `parts`, one after the other."""
        return cls(
            Panels.joined([part.panels for part in parts]),
            np.concatenate([part.coefficients for part in parts]),
            np.concatenate([part.truncation_errors for part in parts]),
        )


def primitive_of(
    kind: IntegralKind, load_power: int, x: Array, largest_advance: float, law: ContactLaw
) -> Primitive:
    """An integral over flat punches at points `x` as a function of its upper end, the advance
    d = a - a_0 of the edge of contact, from 0 to `largest_advance` [length].

    a_0 is the half-width without load. The range is cut into panels, ranges of a variable v in
    which the integrand is smooth. On each the integral is a Chebyshev series, with the sum over the
    panels before as its constant. Its error is the sum of the last coefficients of the integrands
    so far.

    Parameters
    ----------
    kind, load_power
        which integral ("pressure", "outside", "logarithm"); with 1 the load eta stands in front of
        the integrand
    x
        (k,) distances of the points from the middle [length], ascending
    law
        P(d) of the profile; its `corner_advances` are the d at which dP/dd is not smooth,
        `least_half_width` is a_0
    """
    range_ends = _ends_of_smooth_ranges(largest_advance, law)
    # each smooth range of each point, cut further where v is long (_LARGEST_PANEL_LENGTH: 1.2 of
    # "pressure", 0.8 of "outside")
    panels_of_points = _panels_of_points(
        kind, x, law.least_half_width, range_ends, law.corner_advances
    )
    panels_to_resolve = panels_of_points.cut_to(_LARGEST_PANEL_LENGTH[kind])
    # They are halved until the series are resolved. A point without a panel gets one of zeros.
    resolved_series = _resolved_series(kind, load_power, panels_to_resolve, law)
    integrand_series = _with_empty_panels(resolved_series, x).in_order_of_points()
    panels = integrand_series.panels

    # At x = 0 the first range is integrated as a power of the half-width.
    integral_before_panels = _pressure_of_smallest_punches(
        kind, load_power, x, float(range_ends[1]), law
    )
    truncation_errors = integrand_series.truncation_errors
    error_before_panel = _sums_of_panels_before(
        panels.point_number, truncation_errors, np.zeros(len(x))
    )
    return Primitive(
        kind,
        x,
        x - law.least_half_width,
        largest_advance,
        panels,
        begin_advances=panels.advance_at_v0 + panels.advance_beyond_v0(kind, panels.begin_v),
        coefficients=_integrated_series(integrand_series, integral_before_panels),
        error=error_before_panel + truncation_errors,
    )


def _ends_of_smooth_ranges(largest_advance: float, law: ContactLaw) -> Array:
    """Ascending advances d of the edge of contact between which an integral over flat punches is
    taken apart, up to `largest_advance` [length]: corners of the profile, and octaves.

    A small advance has digits of its own in its octave. There are 23 ends of octaves below the
    largest advance; an octave is the factor `advance_ratio_of_series`, 2 or less for high powers.
    `corner_advances` are the d at which dP/dd is not smooth.
    """
    octave_ends = largest_advance / law.advance_ratio_of_series ** np.arange(1, _OCTAVE_COUNT)
    corners_inside = law.corner_advances[law.corner_advances < largest_advance]
    return np.append(np.union1d(corners_inside, octave_ends), largest_advance)


def _integrated_series(integrand_series: _PanelSeries, integral_before_panels: Array) -> Array:
    """Coefficients (nodes, n) of the Chebyshev series of an integral on n panels, from those of its
    integrand: from the start of all panels of a point on.

    The constant of each holds the sum over the panels before it at the same point, and
    `integral_before_panels` (k,) of the k points. Panels, ranges of a variable v, are in the order
    of their points, and of each point outwards. Last terms that are round-off in all series are
    left out.
    """
    panels = integrand_series.panels
    coefficients = chebyshev.chebint(integrand_series.coefficients.T, lbnd=-1)
    coefficients = _without_round_off(coefficients * ((panels.end_v - panels.begin_v) / 2))
    integrals_of_panels = np.sum(coefficients, axis=0)
    coefficients[0] += _sums_of_panels_before(
        panels.point_number, integrals_of_panels, integral_before_panels
    )
    return coefficients


def _sums_of_panels_before(
    point_number: Indices, values_of_panels: Array, value_before_first_panel: Array
) -> Array:
    """For each panel, the sum of the values of the panels before it at its point, (n,), panels in
    order of their points. A panel is a range of the integration variable v.

    One sum through all points would leave the round-off of the largest in the smallest.

    Parameters
    ----------
    point_number
        (n,) number of the point that a panel belongs to
    values_of_panels
        (n,) one for each panel
    value_before_first_panel
        (k,) value before the first panel of each point
    """
    panel_number_at_point = np.arange(len(point_number)) - np.searchsorted(
        point_number, point_number
    )
    # Rows: points; columns: the value before the first panel, then the panels.
    n_columns = int(np.max(panel_number_at_point, initial=0)) + 2
    values_of_points = np.zeros((len(value_before_first_panel), n_columns))
    values_of_points[:, 0] = value_before_first_panel
    values_of_points[point_number, panel_number_at_point + 1] = values_of_panels
    return np.cumsum(values_of_points, axis=1)[point_number, panel_number_at_point]


def _resolved_series(
    kind: IntegralKind, load_power: int, panels: Panels, law: ContactLaw
) -> _PanelSeries:
    """Chebyshev series of an integrand on panels, ranges of the variable v, which are halved until
    the last coefficients of each series are negligible.

    A panel is halved twelve times at most. Last coefficients that halving does not make smaller
    are round-off of P(d) and dP/dd: they count as error.

    Parameters
    ----------
    kind, load_power
        which integral; with 1 the load stands in front of the integrand
    panels
        ranges of v, from `begin_v` to `end_v`; each belongs to the point `point_number`
    law
        P(d) of the profile, d the advance of the edge of contact

    Returns
    -------
    _PanelSeries
        Panels, the halves among them, in any order, with their series and its error.
    """
    finished_series: list[_PanelSeries] = []
    unfinished_panels = panels
    sizes_of_last_coefficients_of_parent = np.full(len(unfinished_panels.point_number), np.inf)
    for n_halvings in range(_MOST_HALVINGS + 1):
        coefficients = _series_of_integrand(kind, load_power, unfinished_panels, law)
        # size of the last coefficients of each series, and the error they leave in its integral
        sizes_of_last_coefficients = truncation_error(coefficients)
        truncation_errors = sizes_of_last_coefficients * (
            (unfinished_panels.end_v - unfinished_panels.begin_v) / 2
        )
        integral_sizes = _sizes_of_integrals(kind, load_power, unfinished_panels, coefficients, law)
        # _NEGLIGIBLE_COEFFICIENT_SHARE: 4e-15
        has_small_error = truncation_errors <= _NEGLIGIBLE_COEFFICIENT_SHARE * integral_sizes
        # Last coefficients of more than 0.9 of those of the panel that was halved are round-off.
        has_roundoff_alone = (
            sizes_of_last_coefficients
            > _COEFFICIENT_RATIO_WITHOUT_GAIN * sizes_of_last_coefficients_of_parent
        )
        is_finished = has_small_error | has_roundoff_alone | (n_halvings == _MOST_HALVINGS)
        series_of_panels = _PanelSeries(unfinished_panels, coefficients, truncation_errors)
        finished_series.append(series_of_panels.take(np.flatnonzero(is_finished)))
        if np.all(is_finished):
            break
        # `halved`: the lower halves of all unfinished panels, then the upper ones
        unfinished_panels = unfinished_panels.take(np.flatnonzero(~is_finished)).halved()
        sizes_of_last_coefficients_of_parent = np.tile(sizes_of_last_coefficients[~is_finished], 2)
    return _PanelSeries.joined(finished_series)


def _sizes_of_integrals(
    kind: IntegralKind, load_power: int, panels: Panels, coefficients: Array, law: ContactLaw
) -> Array:
    """Size of the integral over each of n panels, beside which an error is negligible, (n,).

    It is the mean of the integrand, its first Chebyshev coefficient, times half the length of the
    panel. An integral other than "pressure" has, integrated by parts, a second term, with W at its
    end. Where that is larger, its last digit counts. W is P, or P^2/2 with `load_power` 1.

    Parameters
    ----------
    kind, load_power
        which integral; with 1 the load stands in front of the integrand
    panels
        ranges of the variable v, from `begin_v` to `end_v`
    coefficients
        (n, nodes) of the integrand's Chebyshev series over v
    law
        P of the profile as a function of the advance of the edge of contact
    """
    half_length = (panels.end_v - panels.begin_v) / 2
    size_of_integral = np.abs(coefficients[:, 0]) * half_length
    if kind == "pressure":
        return size_of_integral
    end_advance = panels.advance_at_v0 + panels.advance_beyond_v0(kind, panels.end_v)
    term_at_end = _integral_of_load_power(load_power, law.load(end_advance))
    return np.maximum(size_of_integral, term_at_end)


def _series_of_integrand(
    kind: IntegralKind, load_power: int, panels: Panels, law: ContactLaw
) -> Array:
    """Coefficients (n, nodes) of the Chebyshev series of an integrand over the variable v, one
    series on each of n panels, in chunks of 20,000 panels, which bound the memory.

    Parameters
    ----------
    kind, load_power
        which integral; with 1 the load stands in front of the integrand
    panels
        ranges of v, from `begin_v` to `end_v`
    law
        P of the profile as a function of the advance of the edge of contact
    """
    n_panels = len(panels.point_number)
    series_of_chunks = [np.empty((0, len(CHEBYSHEV_NODES)))]
    for first_panel_number in range(0, n_panels, _PANELS_AT_ONCE):
        chunk = panels.take(
            np.arange(first_panel_number, min(first_panel_number + _PANELS_AT_ONCE, n_panels))
        )
        # v at the Chebyshev nodes, which are those of [-1, 1]
        v = (
            chunk.begin_v[:, None]
            + (chunk.end_v - chunk.begin_v)[:, None] * (1 + CHEBYSHEV_NODES) / 2
        )
        series_of_chunks.append(chebyshev_coefficients(_integrand(kind, load_power, chunk, v, law)))
    return np.concatenate(series_of_chunks)


def _with_empty_panels(series_of_panels: _PanelSeries, x: Array) -> _PanelSeries:
    """Panels, ranges of the integration variable v, with their Chebyshev series, such that every
    point of `x` (k,) has at least one. `panels.point_number` is the point to which each belongs.

    A point without a panel, whose integral is 0 everywhere, gets one with zero coefficients:
    look-ups by point then need no special case.
    """
    point_numbers_without_panel = np.setdiff1d(
        np.arange(len(x)), series_of_panels.panels.point_number
    )
    if not len(point_numbers_without_panel):
        return series_of_panels
    zeros = np.zeros(len(point_numbers_without_panel))
    # v from 0 to 1 with the factor 1
    empty_panels = Panels(
        point_number=point_numbers_without_panel,
        x=x[point_numbers_without_panel],
        advance_at_v0=zeros,
        scale=zeros + 1,
        begin_v=zeros,
        end_v=zeros + 1,
    )
    zero_coefficients = np.zeros(
        (len(point_numbers_without_panel), series_of_panels.coefficients.shape[1])
    )
    return _PanelSeries(
        Panels.joined([series_of_panels.panels, empty_panels]),
        np.concatenate([series_of_panels.coefficients, zero_coefficients]),
        np.append(series_of_panels.truncation_errors, zeros),
    )


def _without_round_off(coefficients: Array) -> Array:
    """Coefficients (m, n) of n Chebyshev series without those orders at the end that are round-off
    in all series.
    """
    largest_coefficient = np.maximum(np.max(np.abs(coefficients), axis=0), 1e-300)
    size_of_order = np.max(np.abs(coefficients) / largest_coefficient, axis=1, initial=0.0)
    last_order = int(np.max(np.flatnonzero(size_of_order > _EPS), initial=0))
    return coefficients[: last_order + 1]


class _AdvanceRanges(NamedTuple):
    """Ranges of the advance d of the edge of contact for each of k points, (k, n) each [length].

    Attributes
    ----------
    begin_advance, end_advance
        advances between which to integrate; empty where the end is not above the start
    advance_at_v0
        advance at which the integration variable v is 0
    scale
        factor of v: the root of a length, or 1
    """

    begin_advance: Array
    end_advance: Array
    advance_at_v0: Array
    scale: Array


def _panels_of_points(
    kind: IntegralKind,
    x: Array,
    least_half_width: float,
    range_ends: Array,
    corner_advances: Array,
) -> Panels:
    """Panels, ranges of the integration variable v, for each point of `x` (k,), on which its
    integrand is smooth and not 0.

    v takes away the roots of the integrand, at the point itself and behind each corner of the
    profile. A panel lies between two successive `range_ends`. v is 0 at an advance `advance_at_v0`
    of the edge of contact, and has a factor, `scale`.

    Parameters
    ----------
    kind
        which integral: "pressure", "outside" (zero for half-widths above x) or "logarithm"
    x
        (k,) distances of the points from the middle [length]
    least_half_width
        contact half-width a_0 without load [length]
    range_ends
        (n + 1,) ascending advances a - a_0 of the edge of contact [length]
    corner_advances
        advances at which the edge is at a corner of the profile, ascending [length]
    """
    number_of_corner_below = np.searchsorted(corner_advances, range_ends[:-1], side="right") - 1
    # (n,) advance at the corner below each range, from where v is measured
    corner_advance = corner_advances[np.clip(number_of_corner_below, 0, None)]
    distance_beyond_flat = x - least_half_width
    column_of_zeros = 0 * distance_beyond_flat[:, None]
    ranges = _AdvanceRanges(
        begin_advance=range_ends[:-1] + column_of_zeros,
        end_advance=range_ends[1:] + column_of_zeros,
        advance_at_v0=corner_advance + column_of_zeros,
        scale=np.ones((len(x), len(corner_advance))),
    )
    if kind == "pressure":
        ranges = _ranges_of_pressure(ranges, x, least_half_width, range_ends)
    elif kind == "outside":
        advance_to_x = distance_beyond_flat[:, None]
        ranges = ranges._replace(
            end_advance=np.minimum(ranges.end_advance, advance_to_x),
            scale=np.sqrt(np.maximum(advance_to_x - corner_advance, 0.0)),
        )
    indices_of_nonempty_ranges = np.nonzero(ranges.end_advance > ranges.begin_advance)
    point_number, _ = indices_of_nonempty_ranges
    advance_at_v0 = ranges.advance_at_v0[indices_of_nonempty_ranges]
    scale = ranges.scale[indices_of_nonempty_ranges]
    begin_v, end_v = (
        _integration_variable(
            kind,
            boundary_advances[indices_of_nonempty_ranges],
            distance_beyond_flat[point_number],
            advance_at_v0,
            scale,
        )
        for boundary_advances in (ranges.begin_advance, ranges.end_advance)
    )
    return Panels(point_number, x[point_number], advance_at_v0, scale, begin_v, end_v)


def _ranges_of_pressure(
    ranges: _AdvanceRanges, x: Array, least_half_width: float, range_ends: Array
) -> _AdvanceRanges:
    """Ranges of integration for the pressure at points x (k,): only flat punches that reach beyond
    a point press there.

    The integration variable v is 0 where the edge of contact reaches the point. If the corner of
    the profile before the range is farther out, v is 0 there. Its scale is the root of the distance
    between point and corner.

    Parameters
    ----------
    ranges
        of the advance of the edge of contact, cut at the corners of the profile; `advance_at_v0`
        holds the advance at the corner before each
    x
        |x| of the points [length]
    least_half_width
        half-length of the flat in the middle of the profile, 0 without one [length]
    range_ends
        advances at which ranges begin and end, ascending [length]
    """
    advance_to_x = (x - least_half_width)[:, None]
    corner_advance = ranges.advance_at_v0
    advance_at_v0 = np.maximum(advance_to_x, corner_advance)
    # Behind the middle itself, a corner at 0 without a flat, P goes as a power of a: twice the
    # distance of the point suits it as a scale.
    squared_scale = np.where(
        corner_advance + least_half_width > 0,
        np.abs(advance_to_x - corner_advance),
        2 * advance_to_x,
    )
    # 1e-24 of the largest advance, in place of 0
    least_squared_scale = max(_LEAST_DISTANCE_RATIO * range_ends[-1], 1e-300)
    # At x = 0 without a flat the first range is integrated as a power of a, by
    # `_pressure_of_smallest_punches`.
    first_advance = np.where(x[:, None] + least_half_width > 0, advance_at_v0, range_ends[1])
    return _AdvanceRanges(
        begin_advance=np.maximum(ranges.begin_advance, first_advance),
        end_advance=ranges.end_advance,
        advance_at_v0=advance_at_v0,
        scale=np.sqrt(np.maximum(squared_scale, least_squared_scale)),
    )


def _integrand(
    kind: IntegralKind, load_power: int, panels: Panels, v: Array, law: ContactLaw
) -> Array:
    """Integrand over the integration variable v of an integral over flat punches, at nodes v (n,
    nodes) of n panels; (n, nodes).

        pressure     g/(pi sqrt(a^2 - x^2)) da/dv        g = dP/da
        outside      W x/(a sqrt(x^2 - a^2)) da/dv
        logarithm    W/a da/dv

    a is the half-width of a punch, P the load up to it. W = P; with `load_power` 1 it is P^2/2, and
    of the pressure P stands in front of g.

    Parameters
    ----------
    kind
        the name of the integral
    load_power
        power of the load in the integrand, 0 or 1
    panels
        ranges of v for one point x each; v is 0 at the advance `advance_at_v0` of the edge of
        contact, and `scale` is its factor
    v
        (n, nodes) values of v in the panels
    law
        P and g (`stiffness`) as functions of the advance a - a_0; a_0, the half-width without load
    """
    x = panels.x[:, None]
    advance_at_v0 = panels.advance_at_v0[:, None]
    scale = panels.scale[:, None]
    advance_beyond_v0 = panels.advance_beyond_v0(kind, v)
    advance = advance_at_v0 + advance_beyond_v0
    # da/dv has this root as a factor
    root_beyond_v0 = np.sqrt(advance_beyond_v0)
    half_width = law.least_half_width + advance
    if kind == "pressure":
        eta_power_times_g = law.stiffness(advance) * (law.load(advance) if load_power else 1.0)
        half_width_beyond_x = (
            np.maximum(advance_at_v0 - (x - law.least_half_width), 0.0) + advance_beyond_v0
        )
        return (
            eta_power_times_g
            * 2
            * root_beyond_v0
            * scale
            * np.cosh(v)
            / np.sqrt(half_width_beyond_x * (half_width + x))
            / np.pi
        )
    load_integral = _integral_of_load_power(load_power, law.load(advance))  # W
    load_integral_over_width = np.where(
        half_width > 0, load_integral / np.where(half_width > 0, half_width, 1.0), 0.0
    )
    # the factor sqrt(x - a) of sqrt(x^2 - a^2) cancels against that of da/dv
    outside_factor = x / np.sqrt(x + half_width) if kind == "outside" else 1.0
    return load_integral_over_width * 2 * root_beyond_v0 * outside_factor


def _pressure_of_smallest_punches(
    kind: IntegralKind, load_power: int, x: Array, advance: float, law: ContactLaw
) -> Array:
    """Pressure in the middle, x = 0, by flat punches of half-widths up to `advance`, without a flat
    face; (k,) for points x [stress]. With `load_power` 1 the load stands in front of the integrand.

    It is 0 at all other points, with a flat face, and for other integrals over punches than the
    `kind` "pressure"; also for a wedge with `load_power` 0.

    At x = 0 the integrand is g/(pi alpha), g = dP/d alpha. P goes as alpha to the power
    `law.exponent` there, so that the integrand is a power too, and is integrated as that.
    """
    if kind != "pressure" or law.least_half_width > 0:
        return np.zeros(len(x))
    # at alpha = advance; `law.stiffness` is g
    eta_power_times_g = float(law.stiffness(np.array(advance)))
    exponent_of_width = law.exponent - 1
    if load_power:
        eta_power_times_g = eta_power_times_g * float(law.load(np.array(advance)))
        exponent_of_width = 2 * law.exponent - 1
    pressure_at_middle = (
        eta_power_times_g / (np.pi * exponent_of_width) if exponent_of_width > 0 else 0.0
    )
    return np.where(x == 0, pressure_at_middle, 0.0)
