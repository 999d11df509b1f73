"""Ciavarella-Jaeger superposition: normal contact as a sum of flat punches, all fields from P(a),
its inverse and its slope.

Between two half-planes every increment dP of the load adds the pressure dP/(pi sqrt(a^2 - x^2)) of
a flat punch of half-width a. So one law P(a) gives pressure, normal approach and what the
tangential problem needs (Ciavarella 1998, Jaeger 1998; in axisymmetric contact the sum of flat
punches goes by the name of Mossakovskii too):

    p(x, P)  = (1/pi) int_x^a g/sqrt(alpha^2 - x^2) d alpha             g = dP/d alpha
    S(x, P)  = int g arccosh(|x|/alpha) d alpha,  alpha < min(a, |x|)   displacement outside a punch
    Lam      = int_c^a g ln(alpha/c) d alpha                            slip area: W gathers it
    int ln(2 L/alpha) dP                                                movement of the bodies against a datum at distance L

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
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from scenes.chebyshev import NODES, clenshaw, series, tail
from semi_analytic.quadrature import gauss, graded

Array = NDArray[np.float64]
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
_RESOLVED, _HALVINGS, _NOISE = 4e-15, 12, 0.9
# Panels that are integrated at a time, and primitives that are kept.
_AT_ONCE, _KEPT = 20_000, 8
# Points that one primitive serves.
_POINTS = 4096
# Share of a^2 below which a difference of squares is taken from the rise of P; the same across
# several corners.
_CLOSE, _NEXT = 0.01, 1e-6
# Of Gauss' nodes between two corners; values that are found at a time.
_BETWEEN, _MEMBERS = 12, 4096
# Share of P - P_b up to which Lam is one smooth integral, and of P from which on it is a
# difference.
_NEARBY, _APART = 0.3, 0.02
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
    load, advance, stiffness : P(d), d(P) and dP/da(d), arrays of any shape; loads per unit
        thickness
    least : a_0, the half-width of no load [length]
    breaks : half-widths of the corners, ascending
    power : P goes as d^power for small d
    extent : largest half-width, where the profile ends
    bends_anywhere : whether P may hardly grow between corners, so that a(P) is all but steep there
    noise : relative error of P and dP/da themselves
    """

    load: Function
    advance: Function
    stiffness: Function
    least: float = 0.0
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
        return np.array([0.0, *(b - self.least for b in self.breaks)])

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
    law : P(a)
    datum_length : L, distance of the datum of rigid movements [length]
    """

    law: ContactLaw
    datum_length: float
    closed_form: ClassVar[bool] = False

    @property
    def least(self) -> float:
        """a for P = 0 [length]."""
        return self.law.least

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
        return self.least + self.law.advance(as_is(load))

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
        return self.least == 0 and self.law.power <= 1

    def _beyond(self, x: ArrayLike) -> Array:
        """How far |x| is beyond the least half-width; 0 inside."""
        return np.maximum(np.abs(as_is(x)) - self.least, 0.0)

    # --- fields of the normal problem

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact; infinite at the tip of a sharp wedge.

        >>> from semi_analytic.profiles import power_law
        >>> contact = PunchSuperposition(
        ...     power_law(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(float(contact.pressure(0.6, np.pi / 4)), 12)  # (E*/2 R) sqrt(a^2 - x^2), a = 1
        0.4
        """
        value = self.pressure_rise(x, load)
        return (
            np.where((as_is(x) == 0) & (as_is(load) > 0), np.inf, np.maximum(value, 0.0))
            if self._sharp
            else value
        )

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
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness].

        The slip of x outside the stick zone is (f A/pi) [S(x, P) - S(x, P_c)] after first loading
        by Q = f (P - P_c).

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
        thickness].

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
        if self.least > 0:
            return np.log(2 * self.datum_length / self.least) - np.log1p(advance / self.least)
        return np.log(2 * self.datum_length) - np.log(np.maximum(advance, np.finfo(float).tiny))

    # --- kernels between a load and a point, from differences of load that are free of cancellation

    def arccosh_ratio(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) = arsinh(sqrt(x^2 - a^2)/a) from P_x - eta >= 0 and the advance
        d(eta).

        0 is returned for eta = 0 and a = 0, where it is multiplied by eta.
        """
        outer, rise, low = np.broadcast_arrays(self._beyond(x), as_is(excess), as_is(advance))
        half = low + self.least
        return np.arcsinh(
            np.sqrt(self._squares_apart(low, np.maximum(outer, low), rise))
            / np.where(half > 0, half, np.inf)
        )

    def inverse_root(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """1/sqrt(a(eta)^2 - x^2) from eta - P_x > 0 and the advance d(eta): pi times the pressure
        of a flat punch of unit load.
        """
        distance, rise, high = np.broadcast_arrays(np.abs(as_is(x)), as_is(excess), as_is(advance))
        square = self._squares_apart(np.minimum(distance - self.least, high), high, rise)
        return 1 / np.sqrt(np.where(square > 0, square, np.inf))

    def _squares_apart(self, low: Array, high: Array, rise: Array) -> Array:
        """Difference of the squares of two half-widths of these advances; of close ones from the
        rise of P between them.

        With more than one corner in between the difference itself has more digits, but for corners
        next to each other.
        """
        square = np.array((high - low) * (high + low + 2 * self.least))
        many = np.searchsorted(self.law.begins, high) - np.searchsorted(self.law.begins, low) > 1
        close = (low >= 0) & (square < np.where(many, _NEXT, _CLOSE) * np.square(high + self.least))
        if np.any(close):
            rate = self._mean_rate(low[close], high[close])
            square[close] = rise[close] / np.where(rate > 0, rate, np.inf)
        return square

    def _mean_rate(self, low: Array, high: Array) -> Array:
        """Rise of P over rise of a^2 between two advances as close as may be: in two parts if there
        is a corner in between.
        """
        end = np.maximum(high, low * (1 + 4 * _EPS))
        begins, number = self.law.begins, np.searchsorted(self.law.begins, low, side="right") - 1
        corner = np.append(begins, np.inf)[number + 1]
        above, below = np.zeros(low.shape), np.zeros(low.shape)
        node, share = gauss(6)
        across = np.flatnonzero(corner < end)
        for some, first, last, behind in (
            (slice(None), low, np.minimum(corner, end), number),
            (across, corner[across], end[across], number[across] + 1),
        ):
            b = begins[behind]
            inner, outer = np.sqrt(np.maximum(first - b, 0.0)), np.sqrt(np.maximum(last - b, 0.0))
            root = inner[:, None] + (outer - inner)[:, None] * node
            at = b[:, None] + root * root
            weight = (outer - inner)[:, None] * share * root
            above[some] += np.sum(weight * self.law.stiffness(at), axis=1)
            below[some] += np.sum(weight * 2 * (at + self.least), axis=1)
        return above / np.where(below > 0, below, 1.0)

    # --- the slip area

    def dissipation_kernel(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) = int_{P_c}^P ln(a(eta)/a(P_c)) d eta from P and P - P_c [force per
        thickness].

        Far apart P ln(a/c) less the rise of int P/alpha; close together int (P - eta) d ln(a), by
        Gauss' rule where that is smooth.

        >>> from semi_analytic.profiles import power_law
        >>> contact = PunchSuperposition(
        ...     power_law(modulus=1.0, exponent=2.0, length=1.0, rise=0.5), datum_length=1.0
        ... )  # Hertz
        >>> round(float(contact.dissipation_kernel(2.0, 1.0)), 12)  # ln 2 - 1/2
        0.19314718056
        """
        p, d = np.broadcast_arrays(as_is(load), as_is(slipped))
        far = self._is_far(p, d)
        result = np.zeros(p.shape)
        for here, area in ((far, self._area_apart), (~far & (d > 0), self._area_within)):
            if np.any(here):
                result[here] = area(p[here], d[here])
        return result

    def _is_far(self, p: Array, d: Array) -> NDArray[np.bool_]:
        """Where Lam of P and P - P_c is taken as a difference of larger numbers; elsewhere as an
        integral of positive terms.
        """
        front = np.maximum(p - d, 0.0)
        number = np.maximum(np.searchsorted(self._begin_loads, front, side="right") - 1, 0)
        smooth = (d < _NEARBY * (front - self._begin_loads[number])) & (
            p <= np.append(self._begin_loads, np.inf)[number + 1]
        )
        if self.bends_anywhere:
            # twelve nodes would miss a half-width at which P hardly grows
            smooth &= d <= _APART * p
        return np.asarray(~smooth & (d > _APART * p))

    def _area_apart(self, load: Array, slipped: Array) -> Array:
        # P - P_c says no more of P_c than its last digit: 0 would stand for any smaller one, and
        # its logarithm for 700.
        upper, lower = both = self.law.advance(
            np.stack([load, np.maximum(load - slipped, _EPS / 4 * load)])
        )
        ratio = np.log1p(
            (upper - lower)
            / np.maximum(self.least + lower, np.finfo(float).tiny * np.maximum(upper, 1.0))
        )
        return load * ratio - np.subtract(*self._logarithm(0, both)[0])

    def _area_within(self, load: Array, slipped: Array) -> Array:
        """From P_c on, between one corner and the next by Gauss' rule in sqrt(P - P_b): a smooth
        function of that is a(P) there.

        Close to no load it goes as any power of P: there by the rule for singular ends.
        """
        front, total = load - slipped, np.zeros(load.shape)
        first = np.searchsorted(self._begin_loads, front, side="right")
        after = np.maximum(np.searchsorted(self._begin_loads, load, side="left"), first)
        count = after - first + 1
        ends, (node, share) = np.append(self._begin_loads, np.inf), gauss(_BETWEEN)
        for at_once in np.split(np.arange(len(load)), np.arange(_MEMBERS, len(load), _MEMBERS)):
            which = np.repeat(at_once, count[at_once])
            behind = (
                np.arange(len(which))
                - np.repeat(np.cumsum(count[at_once]) - count[at_once], count[at_once])
                + first[which]
                - 1
            )
            low, high = (
                np.maximum(front[which], ends[behind]),
                np.minimum(load[which], ends[behind + 1]),
            )
            # Up to P it is what is left of P - P_c, whose digits a difference of loads would lose.
            last = ends[behind + 1] >= load[which]
            length = np.where(
                last, np.maximum(slipped[which] - (low - front[which]), 0.0), high - low
            )
            parts = np.zeros(len(which))
            smooth = (behind > 0) | (length < _NEARBY * low)
            for rooted in (True, False):
                some = smooth == rooted
                if not np.any(some):
                    continue
                here, begin, way = which[some], low[some, None], length[some, None]
                if rooted:
                    inner = np.sqrt(begin - ends[behind[some], None])
                    # none of a span that rounding ends
                    reach = way / np.where(way > 0, inner + np.sqrt(inner * inner + way), 1.0)
                    rise, weight = (
                        reach * node * (2 * inner + reach * node),
                        2 * reach * share * (inner + reach * node),
                    )
                else:
                    rise, weight = (values[:, 0] for values in graded(0.0, way))
                advance = self.law.advance(begin + rise)
                rate = (self.least + advance) * self.law.stiffness(advance)
                # P - eta, with its own digits
                above = slipped[here, None] - ((begin - front[here, None]) + rise)
                parts[some] = np.sum(weight * above / np.where(rate > 0, rate, np.inf), axis=-1)
            total += np.bincount(which, parts, len(total))
        return total

    # --- errors

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Estimated error of the method `name` for these arguments; not below the true one."""
        values = np.broadcast_arrays(*(as_is(v) for v in arguments))
        order, kind = int(name.endswith("_moment")), name.removesuffix("_moment")
        advance = self.law.advance(values[0] if name == "dissipation_kernel" else values[-1])
        half = self.least + advance
        if kind == "pressure":
            value, left = self._pressure(order, np.abs(values[0]), values[1])
            near = np.abs(half - np.abs(values[0]))
            left = left + self._last_digit_of_variable(order, np.abs(values[0]), advance)
        elif kind == "slip_integral":
            value, left = self._outside(order, np.abs(values[0]), values[1])
            near = np.minimum(half, np.abs(values[0])) - self.least
        elif name == "dissipation_kernel":
            return self._area_error(*values)
        else:
            value, left = self._logarithm(order, advance)
            value, near = (
                value + np.abs(values[0]) ** (1 + order) * np.abs(self._log_ratio(advance)),
                half,
            )
        # What the last digit of a half-width does to the result, and errors of P(a).
        last_digit = (
            8 * _EPS * half / np.maximum(near, _EPS * np.maximum(half, np.finfo(float).tiny))
        )
        return left + (last_digit + self.noise + 50 * _EPS) * np.abs(value)

    def _area_error(self, load: Array, slipped: Array) -> Array:
        """Estimated error of Lam from above.

        An integral of positive terms, each with all its digits, loses a share of itself. P ln(a/c)
        - int P/alpha d alpha loses last digits of both, which are P times the same logarithm or
        less, and what the series of the second leaves out.
        """
        value = self.dissipation_kernel(load, slipped)
        upper, lower = self.law.advance(
            np.stack([load, np.maximum(load - slipped, _EPS / 4 * load)])
        )
        logarithm, left = self._logarithm(0, upper)
        ratio = np.log1p(
            (upper - lower)
            / np.maximum(self.least + lower, np.finfo(float).tiny * np.maximum(upper, 1.0))
        )
        of_difference = left + (8 * _EPS + self.noise) * (load * ratio + np.abs(logarithm))
        return (
            np.where(self._is_far(load, slipped), of_difference, 0.0)
            + (_OF_AREA * _EPS + self.noise) * value
        )

    def _last_digit_of_variable(self, order: int, distance: Array, advance: Array) -> Array:
        """What the last digit of v does to the pressure at |x| = `distance`, arrays of one shape.

        The edge is |x - b| sinh^2 v ahead of x, so v (1 + eps) moves it by 2 v eps of that way, and
        p by dp/da times as much. At x = 0 v reaches 28, and p of |x|^n goes as a^(n - 1): for
        |x|^20 that is 2e-13 of p.
        """
        half = self.least + advance
        ahead = half - distance
        root = np.sqrt(np.maximum(ahead, 0.0) / np.where(half > 0, half + distance, np.inf))
        # Of dp/da = g/(pi sqrt(a^2 - x^2)), times the way ahead.
        change = self.law.stiffness(advance) * root / np.pi
        if order:
            change = change * self.law.load(advance)
        from_corner = np.min(np.abs((distance - self.least)[..., None] - self.law.begins), axis=-1)
        scale = np.maximum(from_corner, _CLOSEST * advance)
        v = np.arcsinh(np.sqrt(np.maximum(ahead, 0.0) / np.where(scale > 0, scale, np.inf)))
        return 2 * _EPS * v * change

    # --- the integrals

    @cached_property
    def _begin_loads(self) -> Array:
        return self.law.load(self.law.begins)

    @cached_property
    def _primitives(self) -> dict[tuple[Kind, int], list[Primitive]]:
        """Those of earlier calls: a cache, and nothing else."""
        return {}

    def _primitive(self, kind: Kind, order: int, x: Array, advance: Array) -> tuple[Array, Array]:
        """The integral of a kind at `x` up to `advance`, arrays that broadcast, and its error.

        A primitive has all its digits down to half the octaves below its top. Advances that lie
        further apart are taken in bands, so that none has fewer digits beside a large one than
        alone.
        """
        positive = advance > 0
        if not np.any(positive) or not np.size(x):
            nothing = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(advance)))
            return nothing, nothing
        top, least = float(np.max(advance)), float(np.min(advance, where=positive, initial=np.inf))
        if top < least * self._band:
            return self._primitive_of_band(kind, order, x, advance)
        points, upto = np.broadcast_arrays(x, advance)
        band = np.full(upto.shape, -1)
        band[upto > 0] = np.log(top / upto[upto > 0]) / math.log(self._band)
        value, error = np.zeros(upto.shape), np.zeros(upto.shape)
        for number in range(int(band.max()) + 1):
            here = band == number
            if np.any(here):
                value[here], error[here] = self._primitive_of_band(
                    kind, order, points[here], upto[here]
                )
        return value, error

    @property
    def _band(self) -> float:
        """Ratio of the largest to the least advance that one primitive serves with all its
        digits.
        """
        return float(self.law.octave ** (_OCTAVES // 2))

    def _primitive_of_band(
        self, kind: Kind, order: int, x: Array, advance: Array
    ) -> tuple[Array, Array]:
        """The same for advances of one band, and for zeros."""
        if np.ndim(x) and np.shape(x)[-1] > _POINTS:  # a primitive takes some kilobytes a point
            upto = np.broadcast_to(advance, np.broadcast_shapes(np.shape(x), np.shape(advance)))
            places = [slice(k, k + _POINTS) for k in range(0, np.shape(x)[-1], _POINTS)]
            parts = [self._primitive(kind, order, x[..., here], upto[..., here]) for here in places]
            value, error = (
                np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)
            )
            return value, error
        top = float(np.max(advance))
        points, fold = np.unique(np.ravel(x), return_inverse=True)
        kept = self._primitives.setdefault((kind, order), [])
        for found in kept:
            number = np.minimum(np.searchsorted(found.x, points), len(found.x) - 1)
            if top <= found.top < top * self._band and np.array_equal(found.x[number], points):
                break
        else:
            found, number = primitive(kind, order, points, top, self.law), np.arange(len(points))
            kept[:] = [found, *kept[: _KEPT - 1]]
        return found(*np.broadcast_arrays(number[fold].reshape(np.shape(x)), advance))

    def _pressure(self, order: int, distance: Array, load: Array) -> tuple[Array, Array]:
        advance = self.law.advance(load)
        inside = np.where(distance < self.least + advance, advance, 0.0)
        value, error = self._primitive("pressure", order, distance, inside)
        if self._sharp and order == 0:
            # The tip of a sharp wedge: what lies below the least octave, int g/alpha, has no lower
            # end but differences.
            with np.errstate(divide="ignore"):
                tip = self.law.stiffness(np.zeros(())) / np.pi * np.log(advance / self.datum_length)
            return np.where(distance == 0, tip, np.where(distance < advance, value, 0.0)), error
        return np.where((distance < self.least + advance) & (advance > 0), value, 0.0), error

    def _outside(self, order: int, distance: Array, load: Array) -> tuple[Array, Array]:
        """int W x/(alpha sqrt(x^2 - alpha^2)) and what integration by parts leaves at the upper
        end.
        """
        advance, outer = self.law.advance(load), self._beyond(distance)
        inner = np.minimum(advance, outer)
        value, error = self._primitive("outside", order, distance, inner)
        force = np.minimum(load, self.law.load(outer))
        half = inner + self.least
        root = np.sqrt((outer - inner) * (outer + inner + 2 * self.least))
        reach = np.arcsinh(root / np.where(half > 0, half, np.inf))
        return value + (force * force / 2 if order else force) * reach, error

    def _logarithm(self, order: int, advance: Array) -> tuple[Array, Array]:
        """int_0^a P/alpha d alpha, of order 1 int_0^a P^2/(2 alpha) d alpha, and the error."""
        value, error = self._primitive("logarithm", order, np.zeros(1), advance.reshape(-1, 1))
        return value.reshape(advance.shape), error.reshape(advance.shape)


@dataclass(frozen=True, eq=False)
class Panels:
    """Ranges [begin, end] of v: `point` (n,) whose they are, `low` the advance at v = 0, `scale` =
    sqrt(|x - b|) or 1.
    """

    point: Indices
    x: Array
    low: Array
    scale: Array
    begin: Array
    end: Array

    def take(self, which: Indices) -> Panels:
        """Some of them."""
        return Panels(*(values[which] for values in vars(self).values()))

    def advance(self, kind: Kind, v: Array) -> Array:
        """Delta - `low` at v, (n,) or (n, nodes)."""
        scale = self.scale.reshape(-1, *[1] * (v.ndim - 1))
        if kind == "pressure":
            return np.square(scale * np.sinh(v))
        return np.square(scale * np.sin(v) if kind == "outside" else v)


@dataclass(frozen=True, eq=False)
class Primitive:
    """One of the integrals at points `x` (k,), ascending, as a function of the advance up to `top`.

    Attributes
    ----------
    beyond : (k,) x - a_0
    panels, first : where each series holds; advance at its lower end
    coefficients : (m, n) of the primitive over each panel
    error : (n,) what the series of a point left out up to the end of each panel may be worth
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
        """The integral up to `advance` at the points of these numbers, arrays of one shape, and its
        error.
        """
        panels = self.panels
        rank = np.searchsorted(self._firsts, advance, side="right")
        number = np.searchsorted(self._keys, self._key(point, rank), side="right") - 1
        # Below its first panel a point has nothing yet.
        number = np.maximum(number, np.searchsorted(panels.point, point))
        v = _variable(
            self.kind, advance, self.beyond[point], panels.low[number], panels.scale[number]
        )
        begin, end = panels.begin[number], panels.end[number]
        t = np.clip((2 * v - begin - end) / (end - begin), -1.0, 1.0)
        return clenshaw(self.coefficients, number, t), self.error[number]

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


def _variable(kind: Kind, advance: Array, beyond: Array, low: Array, scale: Array) -> Array:
    """V of an advance; `beyond` is x - a_0."""
    root = np.sqrt(np.maximum(advance - low, 0.0))
    if kind == "pressure":
        return np.arcsinh(root / scale)
    return (
        np.arctan2(root, np.sqrt(np.maximum(beyond - advance, 0.0))) if kind == "outside" else root
    )


def primitive(kind: Kind, order: int, x: Array, top: float, law: ContactLaw) -> Primitive:
    """The integral of a kind and order (1 has eta in front) at points `x` (k,), ascending, up to
    the advance `top`.
    """
    begins, beyond = law.begins, x - law.least
    # Octaves, so that a small advance has digits of its own.
    marks = np.append(
        np.union1d(begins[begins < top], top / law.octave ** np.arange(1, _OCTAVES)), top
    )
    ranges = _ranges(kind, x, law.least, marks, begins)
    done: list[tuple[Panels, Array, Array]] = []
    coarse = np.full(len(ranges.point), np.inf)
    for turn in range(_HALVINGS + 1):
        parts = [np.empty((0, len(NODES)))]
        for k in range(0, len(ranges.point), _AT_ONCE):
            some = ranges.take(np.arange(k, min(k + _AT_ONCE, len(ranges.point))))
            v = some.begin[:, None] + (some.end - some.begin)[:, None] * (1 + NODES) / 2
            parts.append(series(_integrand(kind, order, some, v, law)))
        found = np.concatenate(parts)
        length = (ranges.end - ranges.begin) / 2
        rest, size = tail(found), np.abs(found[:, 0]) * length
        if kind != "pressure":
            # By parts W stands there too: where that is larger, its last digit counts.
            force = law.load(ranges.low + ranges.advance(kind, ranges.end))
            size = np.maximum(size, force * force / 2 if order else force)
        # What halving does not make smaller is noise of the laws themselves: it stays, and counts
        # as error.
        good = (rest * length <= _RESOLVED * size) | (rest > _NOISE * coarse) | (turn == _HALVINGS)
        done.append((ranges.take(np.flatnonzero(good)), found[good], (rest * length)[good]))
        left = ranges.take(np.flatnonzero(~good))
        if not len(left.point):
            break
        middle, coarse = (left.begin + left.end) / 2, np.tile(rest[~good], 2)
        ranges = Panels(*(np.tile(values, 2) for values in vars(left).values()))
        ranges.end[: len(middle)], ranges.begin[len(middle) :] = middle, middle
    every = Panels(
        *(
            np.concatenate(part)
            for part in zip(*(vars(each).values() for each, *_ in done), strict=True)
        )
    )
    found, tails = (np.concatenate([each[k] for each in done]) for k in (1, 2))
    missing = np.setdiff1d(np.arange(len(x)), every.point)
    if len(missing):
        # A point without a panel gets one on which its integral is 0.
        zero = np.zeros(len(missing))
        empty = Panels(missing, x[missing], zero, zero + 1, zero, zero + 1)
        every = Panels(
            *(
                np.concatenate(pair)
                for pair in zip(vars(every).values(), vars(empty).values(), strict=True)
            )
        )
        found, tails = (
            np.concatenate([found, np.zeros((len(missing), found.shape[1]))]),
            np.append(tails, zero),
        )
    order_of = np.lexsort((every.begin, every.low, every.point))
    every, found, tails = every.take(order_of), found[order_of], tails[order_of]
    whole = chebyshev.chebint(found.T, lbnd=-1) * ((every.end - every.begin) / 2)
    # What all series are resolved without is round-off.
    size = np.abs(whole) / np.maximum(np.max(np.abs(whole), axis=0), 1e-300)
    whole = whole[
        : int(np.max(np.flatnonzero(np.max(size, axis=1, initial=0.0) > _EPS), initial=0)) + 1
    ]
    # Sums run from panel to panel of a point: one sum through all points would leave the round-off
    # of the largest in the smallest.
    place = np.arange(len(tails)) - np.searchsorted(every.point, every.point)
    table = np.zeros((len(x), int(np.max(place, initial=0)) + 2))
    table[every.point, place + 1] = tails
    error = np.cumsum(table, axis=1)[every.point, place + 1]
    table[every.point, place + 1] = np.sum(whole, axis=0)
    table[:, 0] = _at_the_bottom(kind, order, x, float(marks[1]), law)
    whole[0] += np.cumsum(table, axis=1)[every.point, place]
    return Primitive(
        kind, x, beyond, top, every, every.low + every.advance(kind, every.begin), whole, error
    )


def _ranges(kind: Kind, x: Array, least: float, marks: Array, begins: Array) -> Panels:
    """Ranges of v between marks that are not empty, for each point, cut to the greatest length."""
    b = begins[np.clip(np.searchsorted(begins, marks[:-1], side="right") - 1, 0, None)]
    beyond = x - least
    at, low, high = (
        beyond[:, None],
        marks[:-1] + 0 * beyond[:, None],
        marks[1:] + 0 * beyond[:, None],
    )
    if kind == "pressure":
        origin = np.maximum(at, b)
        # From the middle itself, x = b = 0 with no flat there, the law is a power up to the first
        # mark: see `_at_the_bottom`.
        scale = np.sqrt(
            np.maximum(
                np.where(b + least > 0, np.abs(at - b), 2 * at), max(_CLOSEST * marks[-1], 1e-300)
            )
        )
        low = np.maximum(low, np.where(x[:, None] + least > 0, origin, marks[1]))
    elif kind == "outside":
        origin, scale, high = b + 0 * at, np.sqrt(np.maximum(at - b, 0.0)), np.minimum(high, at)
    else:
        origin, scale = b + 0 * at, np.ones((len(x), len(b)))
    here = np.nonzero(high > low)
    point, start, size = here[0], origin[here], scale[here]
    inner, outer = (_variable(kind, edge[here], beyond[point], start, size) for edge in (low, high))
    count = np.maximum(np.ceil((outer - inner) / _LONGEST[kind]), 1).astype(int)
    which = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    step = ((outer - inner) / count)[which]
    begin = inner[which] + number * step
    end = np.where(number == count[which] - 1, outer[which], begin + step)
    return Panels(point[which], x[point[which]], start[which], size[which], begin, end)


def _integrand(kind: Kind, order: int, panels: Panels, v: Array, law: ContactLaw) -> Array:
    """The integrands over v, (n, nodes)."""
    x, low, scale = panels.x[:, None], panels.low[:, None], panels.scale[:, None]
    above = panels.advance(kind, v)
    advance = low + above
    root, half = np.sqrt(above), law.least + advance
    if kind == "pressure":
        weight = law.stiffness(advance) * (law.load(advance) if order else 1.0)
        inside = np.maximum(low - (x - law.least), 0.0) + above
        return weight * 2 * root * scale * np.cosh(v) / np.sqrt(inside * (half + x)) / np.pi
    force = law.load(advance)
    weight = np.where(
        half > 0, (force * force / 2 if order else force) / np.where(half > 0, half, 1.0), 0.0
    )
    return weight * 2 * root * (x / np.sqrt(x + half) if kind == "outside" else 1.0)


def _at_the_bottom(kind: Kind, order: int, x: Array, advance: float, law: ContactLaw) -> Array:
    """What a pressure at x = 0 gathers below the least octave, (k,): there P and int g/alpha go as
    powers of a.
    """
    if kind != "pressure" or law.least > 0:
        return np.zeros(len(x))
    rate = float(law.stiffness(np.array(advance))) * (
        float(law.load(np.array(advance))) if order else 1.0
    )
    power = (law.power if order == 0 else 2 * law.power) - 1
    return np.where(x == 0, rate / (np.pi * power) if power > 0 else 0.0, 0.0)
