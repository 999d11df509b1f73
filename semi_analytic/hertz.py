"""Hertz law: normal contact of the parabola h = x^2 / (2 R), everything in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from scenes.array_types import Array

# Coefficients of 2 artanh y - 2 y; with eleven terms it leaves 2e-16 up to a ratio of 0.3.
_TAIL_COEFFICIENTS = (2 / np.arange(3.0, 25.0, 2.0)).tolist()
_LARGEST_RATIO_OF_SERIES = 0.3
_NUMBER_BELOW_ONE = 1 - 2.0**-53


def log_excess(ratio: ArrayLike) -> Array:
    """-ln(1 - r) - r = r^2/2 + r^3/3 + ... of `ratio` r, 0 <= r <= 1, of any shape, to full
    relative accuracy, however small r is.

    Friction work of Hertz contacts needs it (`HertzContact.dissipation_kernel`), r = (P - P_c)/P
    with P_c the load at the stick edge. For r = 1 the floating-point number before it is taken,
    since ln 0 would spoil an integral over r. Small r take a series, in which nothing cancels.

    >>> float(log_excess(1e-9)) * 2e18, round(float(log_excess(0.5)), 12)
    (1.000000000..., 0.19314718056)
    """
    ratios = np.asarray(ratio, dtype=float)
    # _LARGEST_RATIO_OF_SERIES: 0.3
    if not np.any(ratios > _LARGEST_RATIO_OF_SERIES):
        return _log_series(ratios)
    excess = np.asarray(-np.log1p(-np.minimum(ratios, _NUMBER_BELOW_ONE)) - ratios)
    is_small_ratio = ratios <= _LARGEST_RATIO_OF_SERIES
    excess[is_small_ratio] = _log_series(ratios[is_small_ratio])
    return excess


def _log_series(ratio: Array) -> Array:
    """-ln(1 - r) - r of ratios r up to 0.3, by eleven terms of the series of 2 artanh y - 2 y,
    y = r/(2 - r).

    -ln(1 - r) = 2 artanh y and 2 y - r = r^2/(2 - r), so that nothing cancels.
    """
    two_minus_ratio = 2 - ratio
    y = ratio / two_minus_ratio
    squared_y = y * y
    series_tail = _TAIL_COEFFICIENTS[-1]
    for coefficient in _TAIL_COEFFICIENTS[-2::-1]:
        series_tail = series_tail * squared_y + coefficient
    return ratio * ratio / two_minus_ratio + series_tail * y * squared_y


@dataclass(frozen=True)
class HertzContact:
    """Two half-planes pressed together by a parabola. Every method takes arrays that broadcast;
    loads per unit thickness.

    # notation: a half-width, P or eta normal load, E* composite modulus, R radius, L datum length,
    P_x load at which a = |x|

    P = pi E* a^2 / (4 R),  p(x, P) = (E*/(2 R)) sqrt(a^2 - x^2)

    Attributes
    ----------
    modulus
        E* [stress]
    radius
        R [length]
    datum_length
        L, distance of the datum of displacements and approach [length]
    has_closed_form
        True: kernels and integrals need no quadrature
    half_width_may_be_steep
        False: P grows everywhere with a
    corner_half_widths, corner_loads
        empty: a parabola has no corners, at which dP/da is not smooth
    least_half_width
        0, the half-width under no load [length]
    extent
        infinite: largest half-width, at which the profile ends [length]
    relative_roundoff
        relative error of P(a) and dP/da
    """

    modulus: float
    radius: float
    datum_length: float
    has_closed_form: ClassVar[bool] = True
    half_width_may_be_steep: ClassVar[bool] = False
    corner_half_widths: ClassVar[tuple[float, ...]] = ()
    corner_loads: ClassVar[Array] = np.empty(0)
    least_half_width: ClassVar[float] = 0.0
    extent: ClassVar[float] = np.inf
    relative_roundoff: ClassVar[float] = 2 * float(np.finfo(float).eps)

    @property
    def square_width_per_load(self) -> float:
        """a^2/P = 4 R/(pi E*) [length / stress], the same at every load."""
        return 4 * self.radius / (np.pi * self.modulus)

    def half_width(self, load: ArrayLike) -> Array:
        """Half-width of contact a(P) = sqrt(4 R P/(pi E*)) of a parabola of radius R on a
        half-plane under the load P [length]. E* is the composite modulus.

        >>> round(
        ...     float(
        ...         HertzContact(modulus=100.0, radius=1.0, datum_length=1.0).half_width(25 * np.pi)
        ...     ),
        ...     12,
        ... )
        1.0
        """
        return np.sqrt(self.square_width_per_load * np.asarray(load, dtype=float))

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) = pi E* a^2/(4 R) [force per thickness], the Hertz law, the inverse of `half_width`.

        >>> round(
        ...     float(HertzContact(modulus=100.0, radius=1.0, datum_length=1.0).load(1.0)) / np.pi,
        ...     12,
        ... )
        25.0
        """
        return np.square(np.asarray(half_width, dtype=float)) / self.square_width_per_load

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da = pi E* a/(2 R) [stress]."""
        return 2 * np.abs(np.asarray(half_width, dtype=float)) / self.square_width_per_load

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Hertz pressure p(x, P) = (E*/2R) sqrt(a^2 - x^2) >= 0 [stress] at distances x from the
        middle; 0 outside the contact.

        a is the contact half-width, R the radius. Equation (22) of Davies, Barber and Hills (2012).
        E* is the composite modulus.

        >>> float(
        ...     HertzContact(modulus=100.0, radius=1.0, datum_length=1.0)
        ...     .pressure(0.0, 25 * np.pi)
        ...     .round(12)
        ... )  # 2 P/(pi a)
        50.0
        """
        # P - P_x, P_x the load at which a = |x|; then p = (2/pi) sqrt((P - P_x)/(a^2/P))
        load_beyond_x = np.maximum(np.asarray(load, dtype=float) - self.load(x), 0.0)
        return np.sqrt(load_beyond_x / self.square_width_per_load) * (2 / np.pi)

    pressure_rise = pressure

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load] = p(x, P) (P + 2 P_x)/3."""
        return self.pressure(x, load) * (np.asarray(load, dtype=float) + 2 * self.load(x)) / 3

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Slip integral S(x, P) = int arccosh(|x|/a(eta)) d eta over the loads eta < min(P, P_x)
        [force per thickness], in closed form.

        P_x is the load at which the edge of contact is at x, a(eta) the half-width under the load
        eta. (A/pi) S, A = 2/E*, is the displacement of the surface at the middle of the contact
        minus that at x. S = P arccosh(sqrt(P_x/P)) + P_x - sqrt(P_x (P_x - P)) for P < P_x, and P_x
        beyond. The initial gap closes where the edge comes: x^2/(2 R) = (A/pi) S(x, P_x), R the
        radius of the parabola. E* is the composite modulus.

        >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
        >>> round(2 / np.pi * float(contact.slip_integral(0.6, contact.load(0.6))), 12)  # 0.6^2/2
        0.18
        """
        # P_x; the punches up to the load P_x or P lie within x
        load_at_x = self.load(x)
        punch_load = np.minimum(np.asarray(load, dtype=float), load_at_x)
        load_beyond_punch = load_at_x - punch_load
        # P_x - sqrt(P_x (P_x - P)), without its cancellation; 0 at x = 0
        algebraic_term = (
            load_at_x
            * punch_load
            / (load_at_x + np.sqrt(load_at_x * load_beyond_punch) + _SMALLEST_FLOAT)
        )
        # `_arccosh_root`: arccosh(sqrt(P_x/P)) from P_x - P and P
        return punch_load * _arccosh_root(load_beyond_punch, punch_load) + algebraic_term

    def slip_integral_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """First moment of the slip integral, int eta' arccosh(|x|/a(eta')) d eta' over the loads
        eta' < min(eta, P_x), eta = `load`, in closed form [force^2 per thickness^2].

        a(eta') is the half-width under the load eta', P_x the load at which the edge of contact is
        at x. The integral is (eta^2/2) arccosh(sqrt(P_x/eta)) + (r/4) [2 P_x (r - s) - (2/3)
        (r^3 - s^3)], r = sqrt(P_x), s = sqrt(P_x - eta). It is found by parts: the second term is a
        quarter of int_0^eta eta' sqrt(P_x/(P_x - eta')) d eta'.
        """
        # P_x; the punches up to the load P_x or P lie within x
        load_at_x = self.load(x)
        punch_load = np.minimum(np.asarray(load, dtype=float), load_at_x)
        load_beyond_punch = load_at_x - punch_load
        # notation: r = sqrt(P_x), s = sqrt(P_x - eta)
        r = np.sqrt(load_at_x)
        s = np.sqrt(load_beyond_punch)
        algebraic_term = r * (2 * load_at_x * (r - s) - 2 / 3 * (r**3 - s**3))
        # `_arccosh_root`: arccosh(sqrt(P_x/eta)) from P_x - eta and eta
        return punch_load**2 / 2 * _arccosh_root(load_beyond_punch, punch_load) + algebraic_term / 4

    def edge_advance(self, load: ArrayLike) -> Array:
        """How far the edge is beyond that of no load: a itself [length]."""
        return self.half_width(load)

    load_at = load

    def arccosh_ratio(
        self, x: ArrayLike, load_difference: ArrayLike, half_width_of_punch: ArrayLike
    ) -> Array:
        """arccosh(|x|/a(eta)) of a point x outside a flat punch, from `load_difference` P_x - eta
        >= 0 and `half_width_of_punch` a(eta); 0 for a = 0. P_x is the load at which the edge of
        contact is at x, a(eta) the half-width under the load eta; a^2/P is `square_width_per_load`.
        """
        del x
        half_width = np.asarray(half_width_of_punch, dtype=float)
        return np.arcsinh(
            np.sqrt(self.square_width_per_load * np.asarray(load_difference, dtype=float))
            / np.where(half_width > 0, half_width, np.inf)
        )

    def inverse_root(
        self, x: ArrayLike, load_difference: ArrayLike, half_width_of_punch: ArrayLike
    ) -> Array:
        """1/sqrt(a(eta)^2 - x^2) of a point x inside a flat punch, from `load_difference` eta - P_x
        > 0; 0 where that is 0. P_x is the load at which the edge of contact is at x, a(eta) the
        half-width under the load eta; a^2/P is `square_width_per_load`.
        """
        del x, half_width_of_punch
        difference_of_squares = self.square_width_per_load * np.asarray(
            load_difference, dtype=float
        )
        return 1 / np.sqrt(np.where(difference_of_squares > 0, difference_of_squares, np.inf))

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Error of the values of the method called `name` at its `arguments`: 0, in their common
        shape. Closed forms keep 1e-13 of their own value, which is less than what counts as an
        error.
        """
        del name
        return np.zeros(np.broadcast_shapes(*(np.shape(values) for values in arguments)))

    def approach_integral(self, load: ArrayLike) -> Array:
        """Integral of ln(2 L/a(eta)) over the loads eta from 0 to P, P [ln(2 L/a(P)) + 1/2] [force
        per thickness].

        Times A/pi it is the normal approach of the half-planes, relative to a datum at the distance
        L, `datum_length`; A = 2/E* is the compliance of both, a(eta) the half-width under the load
        eta. E* is the composite modulus.

        >>> contact = HertzContact(
        ...     modulus=100.0, radius=1.0, datum_length=0.5
        ... )  # a = 1 = 2 L at P = 25 pi
        >>> round(float(contact.approach_integral(25 * np.pi)) / (25 * np.pi), 12)
        0.5
        """
        loads = np.asarray(load, dtype=float)
        return loads * (self.log_datum_ratio(loads) + 0.5) * (loads > 0)

    def approach_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta [force^2 per thickness^2] = (P^2/2) [ln(2 L/a) +
        1/4].
        """
        loads = np.asarray(load, dtype=float)
        return loads * loads / 2 * (self.log_datum_ratio(loads) + 0.25) * (loads > 0)

    def log_datum_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P)), L the `datum_length`, a(P) the contact half-width, a^2/P =
        `square_width_per_load`; at P = 0, where it is multiplied by P, the value for P = 1 stands
        in.
        """
        loads = np.asarray(load, dtype=float)
        return -0.5 * np.log(
            np.where(loads > 0, loads, 1.0)
            * self.square_width_per_load
            / (2 * self.datum_length) ** 2
        )

    def dissipation_kernel(self, load: ArrayLike, slip_zone_load: ArrayLike) -> Array:
        """Kernel Lam(P, P_c) of the friction work [force per thickness], the integral of
        ln(a(eta)/a(P_c)) over the loads eta from P_c to P: [P ln(P/P_c) - P + P_c]/2.

        P = `load`, P - P_c = `slip_zone_load`. a(eta) is the half-width under the load eta, P_c the
        load at the stick edge. `log_excess(r)` is -ln(1 - r) - r.

        >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
        >>> round(float(contact.dissipation_kernel(2.0, 1.0)), 12)  # ln 2 - 1/2
        0.19314718056
        """
        loads = np.asarray(load, dtype=float)
        return (
            loads
            / 2
            * log_excess(np.asarray(slip_zone_load, dtype=float) / np.where(loads > 0, loads, 1.0))
        )


_SMALLEST_FLOAT = np.finfo(float).tiny


def _arccosh_root(load_beyond_punch: Array, load: Array) -> Array:
    """arccosh(|x|/a(eta)) = arccosh(sqrt(P_x/eta)) of a parabola, of a point x outside the punch of
    the load eta.

    Given are `load_beyond_punch` = P_x - eta and `load` = eta, by which it is arsinh(sqrt((P_x -
    eta)/eta)). P_x is the load at which the edge of contact is at x. For eta = 0, where the caller
    multiplies by eta, the value is 0.
    """
    return np.arcsinh(np.sqrt(load_beyond_punch / np.where(load > 0, load, np.inf)))
