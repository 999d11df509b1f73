"""Ciavarella-Jaeger superposition: normal contact as a sum of flat punches, all fields from P(a),
its inverse and its slope.

Between two half-planes every increment dP of the load adds the pressure dP/(pi sqrt(a^2 - x^2)) of
a flat punch of half-width a. So one law P(a) gives pressure, normal approach and what the
tangential problem needs (Ciavarella 1998, Jaeger 1998; in axisymmetric contact the sum of flat
punches goes by the name of Mossakovskii too):

    p(x, P)  = (1/pi) int_x^a g/sqrt(alpha^2 - x^2) d alpha             g = dP/d alpha
    S(x, P)  = int g arccosh(|x|/alpha) d alpha,  alpha < min(a, |x|)   displacement outside a punch
    Lam      = int_c^a g ln(alpha/c) d alpha                            slip area: W gathers it
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
from scenes.chebyshev import NODES, clenshaw, series, tail
from semi_analytic.quadrature import gauss, graded

Indices = NDArray[np.intp]
Function = Callable[[Array], Array]
Kind = Literal["pressure", "outside", "logarithm"]

_EPS = float(np.finfo(float).eps)
# Octaves of the advance below the largest that have series of their own.
_OCTAVES = 24
# Longest range of v that one series serves.
_LONGEST = {"pressure": 1.2, "outside": 0.8, "logarithm": np.inf}
# |x - b| over the half-width that stands for 0: its logarithm is 55.
_CLOSEST = 1e-24
# Share of an integral at which a series is resolved; halvings at most; what halving must at least
# gain.
_RESOLVED = 4e-15
_HALVINGS = 12
_NOISE = 0.9
# Panels that are integrated at a time, and primitives that are kept.
_AT_ONCE = 20_000
_KEPT = 8
# Points that one primitive serves.
_POINTS = 4096
# Share of a^2 below which a difference of squares is taken from the rise of P; the same across
# several corners.
_CLOSE = 0.01
_NEXT = 1e-6
# Of Gauss' nodes between two corners; values that are found at a time.
_BETWEEN = 12
_MEMBERS = 4096
# Share of P - P_b up to which Lam is one smooth integral, and of P from which on it is a
# difference.
_NEARBY = 0.3
_APART = 0.02
# Last digits that Lam loses at most where it is an integral: nodes, the inverse a(P) and the slope
# dP/da at each.
_OF_AREA = 100


def as_is(values: ArrayLike) -> Array:
    """Numbers as an array."""
    return np.asarray(values, dtype=float)


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """P(a) of one profile between two given materials, as functions of the advance d = a - a_0 of
    the edge.

    Attributes
    ----------
    load, advance, stiffness
        P(d), d(P) and dP/da(d), arrays of any shape; loads per unit thickness
    least_half_width
        a_0, the half-width of no load [length]
    breaks
        half-widths of the corners, ascending
    power
        P goes as d^power for small d
    extent
        largest half-width, where the profile ends
    bends_anywhere
        whether P may hardly grow between corners, so that a(P) is all but steep there
    noise
        relative error of P and dP/da themselves
    """

    load: Function
    advance: Function
    stiffness: Function
    least_half_width: float = 0.0
    breaks: tuple[float, ...] = ()
    power: float = 2.0
    extent: float = np.inf
    bends_anywhere: bool = False
    noise: float = 2 * _EPS

    @cached_property
    def begins(self) -> Array:
        """Advances from 0 up behind which P and dP/da are one smooth function each of the root of
        the distance.
        """
        return np.array([0.0, *(b - self.least_half_width for b in self.breaks)])

    @property
    def octave(self) -> float:
        """Ratio of advances that one series serves: 2, or less where P would fall by more than
        2^3.
        """
        return float(2.0 ** min(1.0, 3.0 / self.power))


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
    closed_form: ClassVar[bool] = False

    @property
    def least_half_width(self) -> float:
        """a for P = 0 [length]."""
        return self.law.least_half_width

    @property
    def breaks(self) -> tuple[float, ...]:
        """Half-widths at which dP/da is not smooth."""
        return self.law.breaks

    @property
    def bends_anywhere(self) -> bool:
        """Whether P may hardly grow somewhere between the corners."""
        return self.law.bends_anywhere

    @property
    def noise(self) -> float:
        """Relative error of P(a) and dP/da themselves."""
        return self.law.noise

    @property
    def extent(self) -> float:
        """Largest half-width: where the profile ends [length]."""
        return self.law.extent

    @cached_property
    def break_loads(self) -> Array:
        """Loads at which the edge is at a corner, (n,) ascending."""
        return self.load(np.array(self.breaks, dtype=float))

    # --- the law of normal contact

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness], 0 below the least half-width."""
        return self.law.load(self._beyond(half_width))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]. InputError for a load that needs a contact wider than the profile."""
        return self.least_half_width + self.law.advance(as_is(load))

    def advance(self, load: ArrayLike) -> Array:
        """a(P) - a(0), with all its digits beside a flat too [length]."""
        return self.law.advance(as_is(load))

    def load_at(self, advance: ArrayLike) -> Array:
        """P from the advance of the edge, the inverse of `advance` [force per thickness]."""
        return self.law.load(as_is(advance))

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da >= 0 [stress]."""
        return self.law.stiffness(self._beyond(half_width))

    @property
    def _sharp(self) -> bool:
        """Whether the profile is a wedge, whose pressure is infinite at the tip."""
        return self.least_half_width == 0 and self.law.power <= 1

    def _beyond(self, x: ArrayLike) -> Array:
        """How far |x| is beyond the least half-width; 0 inside."""
        return np.maximum(np.abs(as_is(x)) - self.least_half_width, 0.0)

    # --- fields of the normal problem

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Contact pressure p(x, P) >= 0 at a point under a load [stress]: 0 outside the contact,
        infinite at the tip of a sharp wedge.

        >>> from semi_analytic.profiles import power_law
        >>> contact = PunchSuperposition(
        ...     power_law(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(float(contact.pressure(0.6, np.pi / 4)), 12)  # (E*/2 R) sqrt(a^2 - x^2), a = 1
        0.4
        """
        pressure = self.pressure_rise(x, load)
        if not self._sharp:
            return pressure
        is_tip = (as_is(x) == 0) & (as_is(load) > 0)
        return np.where(is_tip, np.inf, np.maximum(pressure, 0.0))

    def pressure_rise(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P), of which differences between loads are taken; at the tip of a sharp wedge (g/pi)
        ln a, from a datum [stress].
        """
        value = self._pressure(0, np.abs(as_is(x)), as_is(load))[0]
        return value if self._sharp else np.maximum(value, 0.0)

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load]."""
        return np.maximum(self._pressure(1, np.abs(as_is(x)), as_is(load))[0], 0.0)

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]:
        what the flat punches that end inside of x add to the slip there.

        a(eta) is the contact half-width under the load eta, P_x the load at which the edge of
        contact reaches x. First loading by Q = f (P - P_c) makes the slip (f A/pi) [S(x, P) - S(x,
        P_c)] outside the stick zone.

        >>> from semi_analytic.profiles import power_law
        >>> contact = PunchSuperposition(
        ...     power_law(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(
        ...     2 / np.pi * float(contact.slip_integral(0.6, contact.load(0.6))), 12
        ... )  # h = 0.6^2/2 at the edge of contact
        0.18
        """
        return np.maximum(self._outside(0, np.abs(as_is(x)), as_is(load))[0], 0.0)

    def slip_integral_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x)."""
        return np.maximum(self._outside(1, np.abs(as_is(x)), as_is(load))[0], 0.0)

    def log_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P)); that of the smallest number for a = 0, where it is multiplied by P."""
        return self._log_ratio(self.law.advance(as_is(load)))

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta = P ln(2 L/a) + int_0^a P/alpha d alpha [force per
        thickness]: times A/pi the normal approach of two half-planes, against a datum at distance
        L.

        >>> from semi_analytic.profiles import power_law
        >>> contact = PunchSuperposition(
        ...     power_law(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(
        ...     float(contact.log_distance(np.pi / 4) * 4 / np.pi - np.log(2)), 12
        ... )  # a = 1 = L: ln 2 + 1/2
        0.5
        """
        p = as_is(load)
        advance = self.law.advance(p)
        return p * self._log_ratio(advance) + self._logarithm(0, advance)[0]

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta = P^2 ln(2 L/a)/2 + int_0^a P^2/(2 alpha) d alpha."""
        p = as_is(load)
        advance = self.law.advance(p)
        return p * p * self._log_ratio(advance) / 2 + self._logarithm(1, advance)[0]

    def _log_ratio(self, advance: Array) -> Array:
        if self.least_half_width > 0:
            return np.log(2 * self.datum_length / self.least_half_width) - np.log1p(
                advance / self.least_half_width
            )
        return np.log(2 * self.datum_length) - np.log(np.maximum(advance, np.finfo(float).tiny))

    # --- kernels between a load and a point, from differences of load that are free of cancellation

    def arccosh_ratio(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) of a point x outside a flat punch of half-width a(eta), with all its
        digits close to the punch.

        It is arsinh(sqrt(x^2 - a^2)/a); the difference of squares is taken from the difference of
        loads. 0 is returned for a = 0, where the value is multiplied by eta = 0.

        Parameters
        ----------
        excess
            P_x - eta >= 0, P_x the load at which the edge of contact reaches x [force per
            thickness]
        advance
            a(eta) - a(0) [length]
        """
        outer_advance, load_rise, inner_advance = np.broadcast_arrays(
            self._beyond(x), as_is(excess), as_is(advance)
        )
        half_width = inner_advance + self.least_half_width
        square_difference = self._squares_apart(
            inner_advance, np.maximum(outer_advance, inner_advance), load_rise
        )
        return np.arcsinh(np.sqrt(square_difference) / np.where(half_width > 0, half_width, np.inf))

    def inverse_root(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """1/sqrt(a(eta)^2 - x^2) [1/length] of a point x inside a flat punch of half-width a(eta):
        pi times the pressure of the punch per load.

        `excess` is eta - P_x > 0, P_x the load at which the edge of contact reaches x; `advance` is
        a(eta) - a(0) [length].
        """
        distance, load_rise, outer_advance = np.broadcast_arrays(
            np.abs(as_is(x)), as_is(excess), as_is(advance)
        )
        inner_advance = np.minimum(distance - self.least_half_width, outer_advance)
        square_difference = self._squares_apart(inner_advance, outer_advance, load_rise)
        return 1 / np.sqrt(np.where(square_difference > 0, square_difference, np.inf))

    def _squares_apart(self, inner_advance: Array, outer_advance: Array, load_rise: Array) -> Array:
        """Difference of the squares of two half-widths, outer minus inner, (n,) [length^2], without
        loss of digits where they are close.

        Close half-widths are compared by `load_rise`, the load P between them, over the mean
        dP/d(a^2). With corners of the profile in between the plain difference has more digits,
        unless the corners are next to each other.

        Parameters
        ----------
        inner_advance, outer_advance
            a - a_0 of both, a_0 the half-width without load [length]
        """
        begins = self.law.begins
        square_difference = np.array(
            (outer_advance - inner_advance)
            * (outer_advance + inner_advance + 2 * self.least_half_width)
        )
        corners_between = np.searchsorted(begins, outer_advance) - np.searchsorted(
            begins, inner_advance
        )
        close_share = np.where(corners_between > 1, _NEXT, _CLOSE)
        is_close = (inner_advance >= 0) & (
            square_difference < close_share * np.square(outer_advance + self.least_half_width)
        )
        if np.any(is_close):
            rate = self._mean_rate(inner_advance[is_close], outer_advance[is_close])
            square_difference[is_close] = load_rise[is_close] / np.where(rate > 0, rate, np.inf)
        return square_difference

    def _mean_rate(self, inner_advance: Array, outer_advance: Array) -> Array:
        """Mean of dP/d(a^2) between two contact half-widths that are close, (n,) [stress/length].

        Both are given by their advance a - a_0 beyond the half-width a_0 without load. A corner of
        the profile in between, where dP/da is not smooth, parts the mean in two.
        """
        end_advance = np.maximum(outer_advance, inner_advance * (1 + 4 * _EPS))
        begins = self.law.begins
        corner_below = np.searchsorted(begins, inner_advance, side="right") - 1
        next_corner = np.append(begins, np.inf)[corner_below + 1]
        rise_of_load, rise_of_square = self._rises(
            inner_advance, np.minimum(next_corner, end_advance), begins[corner_below]
        )
        crossing_numbers = np.flatnonzero(next_corner < end_advance)
        load_behind, square_behind = self._rises(
            next_corner[crossing_numbers],
            end_advance[crossing_numbers],
            begins[corner_below[crossing_numbers] + 1],
        )
        rise_of_load[crossing_numbers] += load_behind
        rise_of_square[crossing_numbers] += square_behind
        return rise_of_load / np.where(rise_of_square > 0, rise_of_square, 1.0)

    def _rises(
        self, begin_advance: Array, end_advance: Array, corner: Array
    ) -> tuple[Array, Array]:
        """Half the rise of P and half the rise of a^2 between two advances of the contact edge,
        (n,) each; their quotient is the mean of dP/d(a^2).

        Gauss' rule in the root of the distance from `corner`, the last corner of the profile before
        the first advance: P is smooth in that root.
        """
        nodes, weights_of_nodes = gauss(6)
        begin_root = np.sqrt(np.maximum(begin_advance - corner, 0.0))
        root_length = np.sqrt(np.maximum(end_advance - corner, 0.0)) - begin_root
        roots = begin_root[:, None] + root_length[:, None] * nodes
        advance = corner[:, None] + roots * roots
        weight = root_length[:, None] * weights_of_nodes * roots
        rise_of_load = np.sum(weight * self.law.stiffness(advance), axis=1)
        rise_of_square = np.sum(weight * 2 * (advance + self.least_half_width), axis=1)
        return rise_of_load, rise_of_square

    # --- the slip area

    def dissipation_kernel(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Integral over loads that gives the friction work of slip from the stick edge to the edge
        of contact, Lam(P, P_c) = int_{P_c}^P ln(a(eta)/a(P_c)) d eta [force per thickness].

        Slip by dF dissipates (A/pi) f Lam dF/f. `load` is P, `slipped` the load P - P_c beyond the
        stick edge. Far apart Lam is P ln(a/c) minus the rise of int P/alpha; close together it is
        int (P - eta) d ln(a), by Gauss' rule where that is smooth.

        >>> from semi_analytic.profiles import power_law
        >>> contact = PunchSuperposition(
        ...     power_law(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(float(contact.dissipation_kernel(2.0, 1.0)), 12)  # ln 2 - 1/2
        0.19314718056
        """
        all_loads, all_slipped = np.broadcast_arrays(as_is(load), as_is(slipped))
        is_far = self._is_far(all_loads, all_slipped)
        is_close = ~is_far & (all_slipped > 0)
        kernel = np.zeros(all_loads.shape)
        if np.any(is_far):
            kernel[is_far] = self._kernel_as_difference(all_loads[is_far], all_slipped[is_far])
        if np.any(is_close):
            kernel[is_close] = self._kernel_as_integral(all_loads[is_close], all_slipped[is_close])
        return kernel

    def _is_far(self, load: Array, slipped: Array) -> NDArray[np.bool_]:
        """Where Lam(P, P_c) = int ln(a(eta)/a(P_c)) d eta loses no digits as a difference of larger
        numbers, a boolean for each pair of loads.

        Elsewhere it is taken as a sum of positive terms. `load` is P, `slipped` is P - P_c.
        """
        edge_load = np.maximum(load - slipped, 0.0)
        corner_below = np.maximum(
            np.searchsorted(self._begin_loads, edge_load, side="right") - 1, 0
        )
        next_load = np.append(self._begin_loads, np.inf)[corner_below + 1]
        is_short = slipped < _NEARBY * (edge_load - self._begin_loads[corner_below])
        is_smooth = is_short & (load <= next_load)
        if self.bends_anywhere:
            # twelve nodes would miss a half-width at which P hardly grows
            is_smooth &= slipped <= _APART * load
        return np.asarray(~is_smooth & (slipped > _APART * load))

    def _log_of_widths(self, load: Array, slipped: Array) -> tuple[Array, Array, Array]:
        """ln(a/c) of contact half-width a(P) over stick half-width c(P_c), and the advance of each
        edge beyond the half-width without load [length].

        `load` is P, `slipped` is P - P_c. Of P_c only the last digit of P is left in that
        difference. P_c = 0 would then stand for any smaller number, and its logarithm be 700.
        """
        edge_load = np.maximum(load - slipped, _EPS / 4 * load)
        outer_advance, inner_advance = self.law.advance(np.stack([load, edge_load]))
        least_half = np.finfo(float).tiny * np.maximum(outer_advance, 1.0)
        relative_rise = (outer_advance - inner_advance) / np.maximum(
            self.least_half_width + inner_advance, least_half
        )
        return np.log1p(relative_rise), outer_advance, inner_advance

    def _kernel_as_difference(self, load: Array, slipped: Array) -> Array:
        """P ln(a/c) - int_c^a P/alpha d alpha."""
        logarithm, outer_advance, inner_advance = self._log_of_widths(load, slipped)
        outer_integral, inner_integral = self._logarithm(
            0, np.stack([outer_advance, inner_advance])
        )[0]
        return load * logarithm - (outer_integral - inner_integral)

    def _kernel_as_integral(self, load: Array, slipped: Array) -> Array:
        """Lam(P, P_c) as the integral of (P - eta) d ln(a(eta)) from P_c to P, a sum of positive
        terms.

        `load` is P, `slipped` is P - P_c, (n,) each. Each integral is cut where the edge passes a
        corner of the profile, load P_b. In between a(P) is a smooth function of sqrt(P - P_b), and
        Gauss' rule in that root holds. Close to no load a goes as any power of P: there a rule for
        singular ends is used.
        """
        kernel = np.zeros(load.shape)
        edge_load = load - slipped
        first_corner = np.searchsorted(self._begin_loads, edge_load, side="right")
        last_corner = np.maximum(
            np.searchsorted(self._begin_loads, load, side="left"), first_corner
        )
        counts_of_parts = last_corner - first_corner + 1  # of each integral, from corner to corner
        bounds = np.arange(_MEMBERS, len(load), _MEMBERS)
        for numbers_at_once in np.split(np.arange(len(load)), bounds):
            # each part belongs to one integral, and lies behind the corner number `corner_below`
            integral_of_part = np.repeat(numbers_at_once, counts_of_parts[numbers_at_once])
            parts_before = (
                np.cumsum(counts_of_parts[numbers_at_once]) - counts_of_parts[numbers_at_once]
            )
            number_of_part = np.arange(len(integral_of_part)) - np.repeat(
                parts_before, counts_of_parts[numbers_at_once]
            )
            corner_below = number_of_part + first_corner[integral_of_part] - 1
            integrals = self._integrals_of_parts(
                load[integral_of_part], slipped[integral_of_part], corner_below
            )
            kernel += np.bincount(integral_of_part, integrals, len(kernel))
        return kernel

    def _integrals_of_parts(self, load: Array, slipped: Array, corner_below: Indices) -> Array:
        """Parts (n,) of integrals of (P - eta) d ln(a(eta)) over the load eta [force per
        thickness], each between two corners of the profile.

        A part begins at P_c, or at the load of corner number `corner_below`. It ends at P = `load`,
        or at the load of the next corner. `slipped` is P - P_c, which has more digits than a
        difference.
        """
        corners = np.append(self._begin_loads, np.inf)
        edge_load = load - slipped
        begin_load = np.maximum(edge_load, corners[corner_below])
        end_load = np.minimum(load, corners[corner_below + 1])
        # Up to P it is what is left of P - P_c, whose digits a difference of loads would lose.
        ends_at_load = corners[corner_below + 1] >= load
        slipped_left = np.maximum(slipped - (begin_load - edge_load), 0.0)
        load_spans = np.where(ends_at_load, slipped_left, end_load - begin_load)
        integrals = np.zeros(len(load))
        is_smooth = (corner_below > 0) | (load_spans < _NEARBY * begin_load)
        for by_root in (True, False):
            parts_of_rule = is_smooth == by_root
            if not np.any(parts_of_rule):
                continue
            begin_column = begin_load[parts_of_rule, None]
            span_column = load_spans[parts_of_rule, None]
            if by_root:
                loads_from_begin, weights = _nodes_in_root(
                    begin_column - corners[corner_below[parts_of_rule], None], span_column
                )
            else:
                loads_from_begin, weights = (values[:, 0] for values in graded(0.0, span_column))
            advance = self.law.advance(begin_column + loads_from_begin)
            rates = (self.least_half_width + advance) * self.law.stiffness(advance)
            # P - eta, with its own digits
            load_above = slipped[parts_of_rule, None] - (
                (begin_column - edge_load[parts_of_rule, None]) + loads_from_begin
            )
            integrand = load_above / np.where(rates > 0, rates, np.inf)
            integrals[parts_of_rule] = np.sum(weights * integrand, axis=-1)
        return integrals

    # --- errors

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Estimated error of the values that the method `name` returns for these arguments; not
        below the true one.

        It adds what the Chebyshev series leave out, what the last digits of half-widths do to the
        value, and the error of P(a) itself.
        """
        values = np.broadcast_arrays(*(as_is(argument) for argument in arguments))
        if name == "dissipation_kernel":
            return self._kernel_error(*values)
        load_power = int(name.endswith("_moment"))
        kind = name.removesuffix("_moment")
        advance = self.law.advance(values[-1])
        half_width = self.least_half_width + advance
        if kind == "pressure":
            distance = np.abs(values[0])
            value, error = self._pressure(load_power, distance, values[1])
            error = error + self._last_digit_of_variable(load_power, distance, advance)
            distance_to_edge = np.abs(half_width - distance)
        elif kind == "slip_integral":
            distance = np.abs(values[0])
            value, error = self._outside(load_power, distance, values[1])
            distance_to_edge = np.minimum(half_width, distance) - self.least_half_width
        else:
            value, error = self._logarithm(load_power, advance)
            value = value + np.abs(values[0]) ** (1 + load_power) * np.abs(self._log_ratio(advance))
            distance_to_edge = half_width
        # What the last digit of a half-width does to the result, and errors of P(a).
        least_distance = _EPS * np.maximum(half_width, np.finfo(float).tiny)
        last_digit = 8 * _EPS * half_width / np.maximum(distance_to_edge, least_distance)
        return error + (last_digit + self.noise + 50 * _EPS) * np.abs(value)

    def _kernel_error(self, load: Array, slipped: Array) -> Array:
        """Estimated error, not below the true one, of Lam(P, P_c) = int ln(a(eta)/a(P_c)) d eta.
        `load` is P, `slipped` is P - P_c.

        Where Lam is a sum of positive terms it loses some last digits of itself. As the difference
        P ln(a/c) - int P/alpha d alpha it loses last digits of both terms, and what the series of
        the second leaves out.
        """
        kernel = self.dissipation_kernel(load, slipped)
        logarithm, outer_advance, _ = self._log_of_widths(load, slipped)
        log_integral, series_error = self._logarithm(0, outer_advance)
        size_of_terms = load * logarithm + np.abs(log_integral)
        error_of_difference = series_error + (8 * _EPS + self.noise) * size_of_terms
        error_of_difference = np.where(self._is_far(load, slipped), error_of_difference, 0.0)
        return error_of_difference + (_OF_AREA * _EPS + self.noise) * kernel

    def _last_digit_of_variable(self, load_power: int, distance: Array, advance: Array) -> Array:
        """Change of the pressure at |x| = `distance` by the last digit of v, the variable in which
        its integral is a series; arrays of one shape [stress].

        The edge of contact is |x - b| sinh^2 v beyond x, b the nearest corner of the profile. A
        change of v by eps v moves it by 2 eps v of that distance, and p by dp/da times as much. At
        x = 0 v reaches 28, and p of a profile |x|^n goes as a^(n - 1): for |x|^20 that is 2e-13 of
        p.

        `advance` is a - a_0 of the edge; with `load_power` 1 the load stands in front of the
        integrand.
        """
        half_width = self.least_half_width + advance
        distance_to_edge = half_width - distance
        distance_inside = np.maximum(distance_to_edge, 0.0)
        root_ratio = np.sqrt(
            distance_inside / np.where(half_width > 0, half_width + distance, np.inf)
        )
        # Of dp/da = g/(pi sqrt(a^2 - x^2)), times the way ahead.
        pressure_change = self.law.stiffness(advance) * root_ratio / np.pi
        if load_power:
            pressure_change = pressure_change * self.law.load(advance)
        distance_to_corners = np.abs(
            (distance - self.least_half_width)[..., None] - self.law.begins
        )
        distance_to_corner = np.maximum(np.min(distance_to_corners, axis=-1), _CLOSEST * advance)
        v = np.arcsinh(
            np.sqrt(distance_inside / np.where(distance_to_corner > 0, distance_to_corner, np.inf))
        )
        return 2 * _EPS * v * pressure_change

    # --- the integrals

    @cached_property
    def _begin_loads(self) -> Array:
        return self.law.load(self.law.begins)

    @cached_property
    def _primitives(self) -> dict[tuple[Kind, int], list[Primitive]]:
        """Those of earlier calls: a cache, and nothing else."""
        return {}

    def _primitive(
        self, kind: Kind, load_power: int, x: Array, advance: Array
    ) -> tuple[Array, Array]:
        """An integral over flat punches at points `x`, from no load up to an `advance` a - a_0 of
        the edge of contact, and its error; both arrays broadcast.

        `kind` names the integral: pressure, arccosh outside the punches, or logarithm. With
        `load_power` 1 the load eta stands in front of the integrand. A primitive, the integral as a
        function of its upper end, keeps its digits over a limited ratio of advances; wider apart
        they are taken in bands.
        """
        is_positive = advance > 0
        if not np.any(is_positive) or not np.size(x):
            zeros = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(advance)))
            return zeros, zeros
        largest_advance = float(np.max(advance))
        least_advance = float(np.min(advance, where=is_positive, initial=np.inf))
        if largest_advance < least_advance * self._band:
            return self._primitive_of_band(kind, load_power, x, advance)
        points, advances = np.broadcast_arrays(x, advance)
        band = np.full(advances.shape, -1)
        band[advances > 0] = np.log(largest_advance / advances[advances > 0]) / math.log(self._band)
        integral = np.zeros(advances.shape)
        error = np.zeros(advances.shape)
        for band_number in range(int(band.max()) + 1):
            is_in_band = band == band_number
            if np.any(is_in_band):
                integral[is_in_band], error[is_in_band] = self._primitive_of_band(
                    kind, load_power, points[is_in_band], advances[is_in_band]
                )
        return integral, error

    @property
    def _band(self) -> float:
        """Ratio of the largest to the least advance that one primitive serves with all its
        digits.
        """
        return float(self.law.octave ** (_OCTAVES // 2))

    def _primitive_of_band(
        self, kind: Kind, load_power: int, x: Array, advance: Array
    ) -> tuple[Array, Array]:
        """An integral over flat punches at points `x`, up to advances a - a_0 of the edge of
        contact that lie close enough for one stored primitive; with its error.

        `kind` names the integral; with `load_power` 1 the load eta stands in front of the
        integrand. Advances may be 0 too. `x` and `advance` broadcast.
        """
        if np.ndim(x) and np.shape(x)[-1] > _POINTS:  # a primitive takes some kilobytes a point
            advance_of_points = np.broadcast_to(
                advance, np.broadcast_shapes(np.shape(x), np.shape(advance))
            )
            integrals = []
            errors = []
            for k in range(0, np.shape(x)[-1], _POINTS):
                chunk = slice(k, k + _POINTS)
                integral, error = self._primitive(
                    kind, load_power, x[..., chunk], advance_of_points[..., chunk]
                )
                integrals.append(integral)
                errors.append(error)
            return np.concatenate(integrals, axis=-1), np.concatenate(errors, axis=-1)
        points, number_in_points = np.unique(np.ravel(x), return_inverse=True)
        primitive, index_in_primitive = self._cached_primitive(
            kind, load_power, points, float(np.max(advance))
        )
        return primitive(
            *np.broadcast_arrays(index_in_primitive[number_in_points].reshape(np.shape(x)), advance)
        )

    def _cached_primitive(
        self, kind: Kind, load_power: int, points: Array, largest_advance: float
    ) -> tuple[Primitive, Indices]:
        """A stored integral over flat punches as a function of its upper end, made where none
        of the last eight serves; with the indices of the points in it.

        Parameters
        ----------
        kind, load_power
            which integral; with 1 the load stands in front of the integrand
        points
            (k,) distances |x| [length], ascending
        largest_advance
            largest upper end, a - a_0 of the edge of contact [length]
        """
        cached_primitives = self._primitives.setdefault((kind, load_power), [])
        for primitive in cached_primitives:
            indices = np.minimum(np.searchsorted(primitive.x, points), len(primitive.x) - 1)
            reaches_top = largest_advance <= primitive.top < largest_advance * self._band
            if reaches_top and np.array_equal(primitive.x[indices], points):
                return primitive, indices
        primitive = primitive_of(kind, load_power, points, largest_advance, self.law)
        cached_primitives[:] = [primitive, *cached_primitives[: _KEPT - 1]]
        return primitive, np.arange(len(points))

    def _pressure(self, load_power: int, distance: Array, load: Array) -> tuple[Array, Array]:
        """Pressure at |x| = `distance` under a load, and its error [stress]: int g/(pi sqrt(alpha^2
        - x^2)) d alpha over the flat punches that reach beyond x.

        alpha is the half-width of a punch, g = dP/d alpha its load per half-width. With
        `load_power` 1 the load eta stands in front of g.
        """
        advance = self.law.advance(load)
        is_inside = distance < self.least_half_width + advance
        pressure, error = self._primitive(
            "pressure", load_power, distance, np.where(is_inside, advance, 0.0)
        )
        pressure = np.where(is_inside & (advance > 0), pressure, 0.0)
        if self._sharp and load_power == 0:
            # The tip of a sharp wedge: what lies below the least octave, int g/alpha, has no lower
            # end but differences.
            with np.errstate(divide="ignore"):
                pressure_at_tip = (
                    self.law.stiffness(np.zeros(())) / np.pi * np.log(advance / self.datum_length)
                )
            pressure = np.where(distance == 0, pressure_at_tip, pressure)
        return pressure, error

    def _outside(self, load_power: int, distance: Array, load: Array) -> tuple[Array, Array]:
        """Integral of arccosh(|x|/alpha) dP over the flat punches of half-width alpha < |x| =
        `distance` up to a load, and its error [force per thickness].

        By parts it is int W x/(alpha sqrt(x^2 - alpha^2)) d alpha plus W arccosh(|x|/alpha) at the
        upper end. W = P; with `load_power` 1, where the load stands in front, W = P^2/2.
        """
        advance = self.law.advance(load)
        outer_advance = self._beyond(distance)
        inner_advance = np.minimum(advance, outer_advance)
        integral, error = self._primitive("outside", load_power, distance, inner_advance)
        load_at_x = np.minimum(load, self.law.load(outer_advance))
        half_width = inner_advance + self.least_half_width
        root_of_squares = np.sqrt(
            (outer_advance - inner_advance)
            * (outer_advance + inner_advance + 2 * self.least_half_width)
        )
        arccosh = np.arcsinh(root_of_squares / np.where(half_width > 0, half_width, np.inf))
        return integral + _load_to_power(load_power, load_at_x) * arccosh, error

    def _logarithm(self, load_power: int, advance: Array) -> tuple[Array, Array]:
        """int_0^a P/alpha d alpha, with `load_power` 1 int_0^a P^2/(2 alpha) d alpha, and the
        error.
        """
        value, error = self._primitive("logarithm", load_power, np.zeros(1), advance.reshape(-1, 1))
        return value.reshape(advance.shape), error.reshape(advance.shape)


@dataclass(frozen=True, eq=False)
class Panels:
    """Ranges [begin, end] of the variable v that takes the roots out of the integrands, (n,) each.

    Attributes
    ----------
    point, x
        number of the point that a panel belongs to, and its x [length]
    advance_at_v0
        advance d = a - a_0 of the edge of contact at v = 0 [length]
    scale
        sqrt(|x - b|), b the corner of the profile behind which the panel lies; or 1
    """

    point: Indices
    x: Array
    advance_at_v0: Array
    scale: Array
    begin: Array
    end: Array

    @classmethod
    def together(cls, parts: Sequence[Panels]) -> Panels:
        """The panels of all parts, one after the other."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return cls(*(np.concatenate(column) for column in columns))

    def take(self, numbers: Indices) -> Panels:
        """The panels with these numbers."""
        return Panels(*(values[numbers] for values in vars(self).values()))

    def cut_to(self, largest_length: float) -> Panels:
        """Each panel cut into as few equal parts as are not longer than `largest_length`, in order.

        A panel is a range of the integration variable v that one Chebyshev series serves. The last
        part of a panel ends exactly where the panel did.
        """
        n_parts = np.maximum(np.ceil((self.end - self.begin) / largest_length), 1).astype(int)
        panel_of_part = np.repeat(np.arange(len(n_parts)), n_parts)
        first_part_of_panel = np.cumsum(n_parts) - n_parts
        number_in_panel = np.arange(len(panel_of_part)) - np.repeat(first_part_of_panel, n_parts)
        part_length = ((self.end - self.begin) / n_parts)[panel_of_part]
        whole_panels = self.take(panel_of_part)
        begin = whole_panels.begin + number_in_panel * part_length
        is_last_of_panel = number_in_panel == n_parts[panel_of_part] - 1
        end = np.where(is_last_of_panel, whole_panels.end, begin + part_length)
        return replace(whole_panels, begin=begin, end=end)

    def halved(self) -> Panels:
        """The lower halves of all, then the upper ones."""
        middle = (self.begin + self.end) / 2
        lower_half = replace(self, end=middle)
        upper_half = replace(self, begin=middle)
        return Panels.together([lower_half, upper_half])

    def advance(self, kind: Kind, v: Array) -> Array:
        """Growth of the advance from v = 0 on to v, which is (n,) or (n, nodes)."""
        scale = self.scale.reshape(-1, *[1] * (v.ndim - 1))
        if kind == "pressure":
            return np.square(scale * np.sinh(v))
        return np.square(scale * np.sin(v) if kind == "outside" else v)


@dataclass(frozen=True, eq=False)
class Primitive:
    """One of the integrals at points `x` (k,), ascending, as a function of the advance up to `top`.

    Attributes
    ----------
    beyond
        (k,) x - a_0
    panels, first
        where each series holds; advance at its lower end
    coefficients
        (m, n) of the primitive over each panel
    error
        (n,) what the series of a point left out up to the end of each panel may be worth
    """

    kind: Kind
    x: Array
    beyond: Array
    top: float
    panels: Panels
    first: Array
    coefficients: Array
    error: Array

    def __call__(self, point: Indices, advance: Array) -> tuple[Array, Array]:
        """The integral from no load up to `advance` of the edge of contact at the points numbered
        `point`, arrays of one shape, and its error.

        The panel that holds the advance is looked up: a range of the variable v with one Chebyshev
        series of the integral. The series is then evaluated at v.
        """
        panels = self.panels
        rank_of_advance = np.searchsorted(self._firsts, advance, side="right")
        panel_number = (
            np.searchsorted(self._keys, self._key(point, rank_of_advance), side="right") - 1
        )
        # Below its first panel a point has nothing yet.
        panel_number = np.maximum(panel_number, np.searchsorted(panels.point, point))
        v = _variable(
            self.kind,
            advance,
            self.beyond[point],
            panels.advance_at_v0[panel_number],
            panels.scale[panel_number],
        )
        begin_v = panels.begin[panel_number]
        end_v = panels.end[panel_number]
        place_in_panel = np.clip((2 * v - begin_v - end_v) / (end_v - begin_v), -1.0, 1.0)
        return clenshaw(self.coefficients, panel_number, place_in_panel), self.error[panel_number]

    @cached_property
    def _firsts(self) -> Array:
        """Every advance at which some panel begins, ascending."""
        return np.unique(self.first)

    @cached_property
    def _keys(self) -> Indices:
        """Of each panel, ascending: by its point, then by its first advance."""
        return self._key(self.panels.point, np.searchsorted(self._firsts, self.first, side="right"))

    def _key(self, point: Indices, rank: Indices) -> Indices:
        """One whole number of a point and the rank of an advance: a sum of the two themselves would
        lose the digits of one.
        """
        return point * (len(self._firsts) + 1) + rank


def _variable(
    kind: Kind, advance: Array, beyond_flat: Array, advance_at_v0: Array, scale: Array
) -> Array:
    """The integration variable v that makes an integrand over flat punches smooth, from the advance
    d of their edge; arrays of one shape.

        pressure     d = d0 + scale^2 sinh^2 v
        outside      d = d0 + scale^2 sin^2 v       scale^2 = beyond_flat - d0
        logarithm    d = d0 + v^2

    d0 = `advance_at_v0`; d = a - a_0 is counted from the half-width a_0 without load [length].
    `beyond_flat` is x - a_0 of the point.
    """
    root = np.sqrt(np.maximum(advance - advance_at_v0, 0.0))
    if kind == "pressure":
        return np.arcsinh(root / scale)
    if kind == "outside":
        return np.arctan2(root, np.sqrt(np.maximum(beyond_flat - advance, 0.0)))
    return root


def _nodes_in_root(begin_distance: Array, length_of_span: Array) -> tuple[Array, Array]:
    """Gauss' nodes and weights for integrands that are smooth in the root of the distance from a
    corner of the profile, for many spans of integration at once.

    Returned are the distances of the nodes from the begin of each span and their weights, (n,
    nodes) each. A span begins at `begin_distance` (n, 1) beyond its corner and has `length_of_span`
    (n, 1).
    """
    nodes, weights_of_nodes = gauss(_BETWEEN)
    begin_root = np.sqrt(begin_distance)
    # length 0 of a span that round-off has closed
    root_length = length_of_span / np.where(
        length_of_span > 0, begin_root + np.sqrt(begin_root * begin_root + length_of_span), 1.0
    )
    distances_from_begin = root_length * nodes * (2 * begin_root + root_length * nodes)
    weights = 2 * root_length * weights_of_nodes * (begin_root + root_length * nodes)
    return distances_from_begin, weights


def _load_to_power(load_power: int, force: Array) -> Array:
    """W: P, or P^2/2 for the moments."""
    return force * force / 2 if load_power else force


class _Resolved(NamedTuple):
    """Panels with their series (n, nodes), and what the last coefficients are worth, (n,)."""

    panels: Panels
    coefficients: Array
    tails: Array

    def take(self, numbers: Indices) -> _Resolved:
        """The chosen ones."""
        return _Resolved(self.panels.take(numbers), self.coefficients[numbers], self.tails[numbers])


def primitive_of(kind: Kind, load_power: int, x: Array, top: float, law: ContactLaw) -> Primitive:
    """An integral over flat punches as a function of its upper end, the advance d = a - a_0 of the
    edge of contact, from 0 to `top` [length].

    The integrand is a Chebyshev series on each panel, a range of a variable v that makes it smooth.
    The integral is the sum over the panels before. Its error is the sum of their last coefficients.

    Parameters
    ----------
    kind, load_power
        which integral; with 1 the load eta stands in front of the integrand
    x
        (k,) distances of the points from the middle [length], ascending
    law
        P(d) of the profile
    """
    # Octaves, so that a small advance has digits of its own.
    octaves = top / law.octave ** np.arange(1, _OCTAVES)
    corners = law.begins[law.begins < top]
    ends_of_ranges = np.append(np.union1d(corners, octaves), top)
    panels_of_points = _panels_of_points(kind, x, law.least_half_width, ends_of_ranges, law.begins)
    panels_to_resolve = panels_of_points.cut_to(_LONGEST[kind])
    resolved_panels = _with_empty_panels(_resolved(kind, load_power, panels_to_resolve, law), x)
    panels = resolved_panels.panels
    outwards_at_point = np.lexsort((panels.begin, panels.advance_at_v0, panels.point))
    resolved_panels = resolved_panels.take(outwards_at_point)
    panels = resolved_panels.panels

    coefficients = chebyshev.chebint(resolved_panels.coefficients.T, lbnd=-1)
    coefficients = _without_round_off(coefficients * ((panels.end - panels.begin) / 2))
    integrals_of_panels = np.sum(coefficients, axis=0)
    below_first_panel = _at_the_bottom(kind, load_power, x, float(ends_of_ranges[1]), law)
    coefficients[0] += _sums_before(panels.point, integrals_of_panels, below_first_panel)
    tails = resolved_panels.tails
    error = _sums_before(panels.point, tails, np.zeros(len(x))) + tails
    first_advances = panels.advance_at_v0 + panels.advance(kind, panels.begin)
    return Primitive(
        kind, x, x - law.least_half_width, top, panels, first_advances, coefficients, error
    )


def _sums_before(point: Indices, values: Array, below_first: Array) -> Array:
    """For each panel, the sum of the values of the panels before it at its point, (n,), panels in
    order of their points.

    One sum through all points would leave the round-off of the largest in the smallest.

    Parameters
    ----------
    point
        (n,) number of the point that a panel belongs to
    values
        (n,) one for each panel
    below_first
        (k,) what lies below the first panel of each point
    """
    number_at_point = np.arange(len(point)) - np.searchsorted(point, point)
    # Rows: points; columns: what lies below the first panel, then the panels.
    terms = np.zeros((len(below_first), int(np.max(number_at_point, initial=0)) + 2))
    terms[:, 0] = below_first
    terms[point, number_at_point + 1] = values
    return np.cumsum(terms, axis=1)[point, number_at_point]


def _resolved(kind: Kind, load_power: int, panels: Panels, law: ContactLaw) -> _Resolved:
    """Chebyshev series of an integrand on panels, ranges of the variable v, which are halved until
    the last coefficients of each series no longer count.

    What halving does not make smaller is noise of P(d) and dP/dd themselves: it stays, and counts
    as error. `kind` and `load_power` name the integral, `law` is P(d) of the profile. Panels come
    back in any order.
    """
    finished_panels: list[_Resolved] = []
    last_terms_before = np.full(len(panels.point), np.inf)
    for halvings in range(_HALVINGS + 1):
        series_of_chunks = [np.empty((0, len(NODES)))]
        for k in range(0, len(panels.point), _AT_ONCE):
            chunk = panels.take(np.arange(k, min(k + _AT_ONCE, len(panels.point))))
            v = chunk.begin[:, None] + (chunk.end - chunk.begin)[:, None] * (1 + NODES) / 2
            series_of_chunks.append(series(_integrand(kind, load_power, chunk, v, law)))
        coefficients = np.concatenate(series_of_chunks)
        half_length = (panels.end - panels.begin) / 2
        last_terms = tail(coefficients)
        integral_size = np.abs(coefficients[:, 0]) * half_length
        if kind != "pressure":
            # By parts W stands there too: where that is larger, its last digit counts.
            load_at_end = law.load(panels.advance_at_v0 + panels.advance(kind, panels.end))
            integral_size = np.maximum(integral_size, _load_to_power(load_power, load_at_end))
        is_small = last_terms * half_length <= _RESOLVED * integral_size
        is_noise = last_terms > _NOISE * last_terms_before
        is_done = is_small | is_noise | (halvings == _HALVINGS)
        chebyshev_panels = _Resolved(panels, coefficients, last_terms * half_length)
        finished_panels.append(chebyshev_panels.take(np.flatnonzero(is_done)))
        if np.all(is_done):
            break
        panels = panels.take(np.flatnonzero(~is_done)).halved()
        last_terms_before = np.tile(last_terms[~is_done], 2)
    return _Resolved(
        Panels.together([group.panels for group in finished_panels]),
        np.concatenate([group.coefficients for group in finished_panels]),
        np.concatenate([group.tails for group in finished_panels]),
    )


def _with_empty_panels(resolved_panels: _Resolved, x: Array) -> _Resolved:
    """Panels with their Chebyshev series, such that every point of `x` (k,) has at least one.

    A point without a panel, whose integral is 0 everywhere, gets one with zero coefficients:
    look-ups by point then need no special case.
    """
    missing_points = np.setdiff1d(np.arange(len(x)), resolved_panels.panels.point)
    if not len(missing_points):
        return resolved_panels
    zeros = np.zeros(len(missing_points))
    empty_panels = Panels(
        point=missing_points,
        x=x[missing_points],
        advance_at_v0=zeros,
        scale=zeros + 1,
        begin=zeros,
        end=zeros + 1,
    )
    no_terms = np.zeros((len(missing_points), resolved_panels.coefficients.shape[1]))
    return _Resolved(
        Panels.together([resolved_panels.panels, empty_panels]),
        np.concatenate([resolved_panels.coefficients, no_terms]),
        np.append(resolved_panels.tails, zeros),
    )


def _without_round_off(coefficients: Array) -> Array:
    """Series (m, n) without the orders that are round-off of all of them."""
    largest_coefficient = np.maximum(np.max(np.abs(coefficients), axis=0), 1e-300)
    size_of_order = np.max(np.abs(coefficients) / largest_coefficient, axis=1, initial=0.0)
    last_order = int(np.max(np.flatnonzero(size_of_order > _EPS), initial=0))
    return coefficients[: last_order + 1]


class _AdvanceRanges(NamedTuple):
    """Ranges of the advance of the edge for each of k points, (k, n) each: their ends; the advance
    at which the variable v is 0, and the scale of v, the root of a length or 1.
    """

    begin: Array
    end: Array
    at_v0: Array
    scale: Array


def _panels_of_points(
    kind: Kind, x: Array, least_half_width: float, ends_of_ranges: Array, begins: Array
) -> Panels:
    """Panels of the integration variable v for each point of `x` (k,), on which its integrand is
    smooth and not 0.

    v takes away the roots of the integrand, at the point itself and behind each corner of the
    profile. A panel lies between two successive `ends_of_ranges`.

    Parameters
    ----------
    kind
        which integral
    least_half_width
        contact half-width without load [length]
    ends_of_ranges
        (n + 1,) ascending advances of the edge of contact [length]
    begins
        advances at which the edge passes a corner of the profile, from 0 up [length]
    """
    number_of_corner = np.searchsorted(begins, ends_of_ranges[:-1], side="right") - 1
    corner_advance = begins[np.clip(number_of_corner, 0, None)]
    beyond_flat = x - least_half_width
    column_of_zeros = 0 * beyond_flat[:, None]
    ranges = _AdvanceRanges(
        begin=ends_of_ranges[:-1] + column_of_zeros,
        end=ends_of_ranges[1:] + column_of_zeros,
        at_v0=corner_advance + column_of_zeros,
        scale=np.ones((len(x), len(corner_advance))),
    )
    if kind == "pressure":
        ranges = _ranges_of_pressure(ranges, x, least_half_width, ends_of_ranges)
    elif kind == "outside":
        advance_to_point = beyond_flat[:, None]
        ranges = ranges._replace(
            end=np.minimum(ranges.end, advance_to_point),
            scale=np.sqrt(np.maximum(advance_to_point - corner_advance, 0.0)),
        )
    nonempty_places = np.nonzero(ranges.end > ranges.begin)
    point, _ = nonempty_places
    at_v0 = ranges.at_v0[nonempty_places]
    scale = ranges.scale[nonempty_places]
    begin_v = _variable(kind, ranges.begin[nonempty_places], beyond_flat[point], at_v0, scale)
    end_v = _variable(kind, ranges.end[nonempty_places], beyond_flat[point], at_v0, scale)
    return Panels(point, x[point], at_v0, scale, begin_v, end_v)


def _ranges_of_pressure(
    ranges: _AdvanceRanges, x: Array, least_half_width: float, ends_of_ranges: Array
) -> _AdvanceRanges:
    """Ranges of integration for the pressure at points x (k,): flat punches contribute only from
    where the edge of contact passes the point.

    v, the variable that takes away the root of the integrand, is 0 there, or at the last corner of
    the profile before, whichever is farther out.

    Parameters
    ----------
    ranges
        of the advance of the half-width, cut at the corners of the profile
    x
        |x| of the points [length]
    least_half_width
        of the flat in the middle of the profile, 0 without one [length]
    ends_of_ranges
        advances of the half-width at which ranges begin and end, ascending [length]
    """
    advance_to_point = (x - least_half_width)[:, None]
    corner_advance = ranges.at_v0
    at_v0 = np.maximum(advance_to_point, corner_advance)
    # From the middle itself, x = b = 0 with no flat there, the law is a power up to the first end
    # of a range: see `_at_the_bottom`.
    squared_scale = np.where(
        corner_advance + least_half_width > 0,
        np.abs(advance_to_point - corner_advance),
        2 * advance_to_point,
    )
    least_square = max(_CLOSEST * ends_of_ranges[-1], 1e-300)
    first_advance = np.where(x[:, None] + least_half_width > 0, at_v0, ends_of_ranges[1])
    return _AdvanceRanges(
        begin=np.maximum(ranges.begin, first_advance),
        end=ranges.end,
        at_v0=at_v0,
        scale=np.sqrt(np.maximum(squared_scale, least_square)),
    )


def _integrand(kind: Kind, load_power: int, panels: Panels, v: Array, law: ContactLaw) -> Array:
    """Integrand over the variable v, at nodes v (n, nodes) of panels, for an integral over flat
    punches, (n, nodes).

        pressure     g/(pi sqrt(a^2 - x^2)) da/dv        g = dP/da
        outside      W x/(a sqrt(x^2 - a^2)) da/dv
        logarithm    W/a da/dv

    a is the half-width of a punch, P = `law.load` of its advance a - a_0, a_0 the half-width
    without load. W = P, or P^2/2 with `load_power` 1; with 1 of the pressure P stands in front of
    g. In v the root of the integrand is smooth; a panel is a range of v for one point x.
    """
    x = panels.x[:, None]
    advance_at_v0 = panels.advance_at_v0[:, None]
    scale = panels.scale[:, None]
    advance_beyond_v0 = panels.advance(kind, v)
    advance = advance_at_v0 + advance_beyond_v0
    root = np.sqrt(advance_beyond_v0)
    half_width = law.least_half_width + advance
    if kind == "pressure":
        weight_of_kind = law.stiffness(advance) * (law.load(advance) if load_power else 1.0)
        distance_beyond_x = (
            np.maximum(advance_at_v0 - (x - law.least_half_width), 0.0) + advance_beyond_v0
        )
        return (
            weight_of_kind
            * 2
            * root
            * scale
            * np.cosh(v)
            / np.sqrt(distance_beyond_x * (half_width + x))
            / np.pi
        )
    load = law.load(advance)
    weight_over_width = _load_to_power(load_power, load) / np.where(half_width > 0, half_width, 1.0)
    weight_of_kind = np.where(half_width > 0, weight_over_width, 0.0)
    return weight_of_kind * 2 * root * (x / np.sqrt(x + half_width) if kind == "outside" else 1.0)


def _at_the_bottom(kind: Kind, load_power: int, x: Array, advance: float, law: ContactLaw) -> Array:
    """What the integral for the pressure gathers over the smallest punches, below `advance`, at
    points x (k,); 0 of other integrals and at x > 0.

    At x = 0 the integrand g/alpha, g = dP/d alpha, goes as a power of the half-width alpha. It is
    integrated by that power. With `load_power` 1 the load stands in front.
    """
    if kind != "pressure" or law.least_half_width > 0:
        return np.zeros(len(x))
    rate = float(law.stiffness(np.array(advance)))
    power = law.power - 1
    if load_power:
        rate = rate * float(law.load(np.array(advance)))
        power = 2 * law.power - 1
    at_middle = rate / (np.pi * power) if power > 0 else 0.0
    return np.where(x == 0, at_middle, 0.0)
