"""The law P(a) of every profile by the Abel transform of its slope: load, its inverse and its
slope, with the corners.

# notation: a half-width, a_0 that of no load, d = a - a_0, P normal load per unit thickness, E*
composite modulus, h(x) profile

As functions of the advance d of the edge; of any symmetric profile (Abel transform of the slope
h'):

    P     = E* a int cos(angle) h'(x) d angle,    x = a cos(angle), 0 < angle < pi/2
    dP/da = E* int cos(angle) (x h')' d angle

All else follows from these in `punch_superposition`; the parabola alone has closed forms
throughout, in `hertz`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.polynomial import Polynomial, chebyshev, polynomial
from numpy.typing import ArrayLike, NDArray

from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    PowerLaw,
    Profile,
    ProfileDataError,
    Tabulated,
    Wedge,
)
from scenes.array_types import Array
from scenes.chebyshev import NODES, Pieces, Powers, Unresolved, halved, series
from scenes.profiles import first_fall
from semi_analytic.elasticity import composite_modulus
from semi_analytic.hertz import HertzContact
from semi_analytic.punch_superposition import ContactLaw, Function, PunchSuperposition
from semi_analytic.quadrature import ROOTS, LogisticRule, logistic, panels
from semi_analytic.tilted_profile import (
    ConvexProfile,
    CurvedProfile,
    PiecewiseParabola,
    TiltedProfile,
)

Indices = NDArray[np.intp]
SymmetricContact = HertzContact | PunchSuperposition
Contact = SymmetricContact | TiltedProfile


def contact_of(profile: Profile, materials: Materials) -> SymmetricContact:
    """Normal contact P(a) of a profile between half-planes of two materials, and all that follows
    from it.

    Raises
    ------
    InputError
        For a kind of profile that this engine does not know, and for one under which the contact
        would split into several.
    """
    if isinstance(profile, Tabulated) and not profile.symmetric:
        raise InputError(
            "profile: its two sides are unequal: this takes symmetric profiles, `solve` takes both"
        )
    modulus = composite_modulus(materials)
    datum = getattr(profile, "datum_length", 0.0)
    return _kind_of(profile).contact(modulus, profile, datum)


def convex_profile(profile: Profile) -> ConvexProfile:
    """The profile under any tilt: in closed form where it is made of parabolas, else by quadrature.

    Raises
    ------
    InputError
        For a profile that bends down somewhere: under a tilt its contact may split. For a sharp
        wedge.
    """
    return _kind_of(profile).convex(profile)


class _Kind(NamedTuple):
    """What a kind of profile is in contact: its symmetric contact for E* and a datum length, and
    the profile under any tilt.
    """

    contact: Callable[[float, Any, float], SymmetricContact]
    convex: Callable[[Any], ConvexProfile]

    @classmethod
    def by_law(
        cls, law: Callable[[float, Any], ContactLaw], convex: Callable[[Any], ConvexProfile]
    ) -> _Kind:
        """Of a kind whose P(a) for E* is a law."""

        def contact(modulus: float, profile: Any, datum: float) -> SymmetricContact:
            return PunchSuperposition(law(modulus, profile), datum)

        return cls(contact, convex)


def _kind_of(profile: Profile) -> _Kind:
    """InputError for a kind of profile that this engine does not know."""
    kind = _KINDS.get(type(profile))
    if kind is None:
        raise InputError(
            f"profile.kind = {profile.kind!r}: the half-plane engine does not know this profile"
        )
    return kind


def _convex_hertz(profile: Hertz) -> ConvexProfile:
    return _parabolas([0.0], [1 / profile.radius] * 2, 0.0)


def _convex_flat_rounded(profile: FlatRounded) -> ConvexProfile:
    b = profile.flat_half_length
    edge_curvature = 1 / profile.radius
    return _parabolas([-b, b], [edge_curvature, 0.0, edge_curvature], 0.0)


def _convex_compound(profile: Compound) -> ConvexProfile:
    b = profile.inner_half_length
    inner_curvature = 1 / profile.inner_radius
    outer_curvature = 1 / profile.outer_radius
    return _parabolas([-b, b], [outer_curvature, inner_curvature, outer_curvature], inner_curvature)


def _convex_wedge(profile: Wedge) -> ConvexProfile:
    b = profile.tip_half_length
    tip_curvature = 1 / profile.tip_radius
    return _parabolas([-b, b], [0.0, tip_curvature, 0.0], tip_curvature)


def _convex_table(profile: Tabulated) -> ConvexProfile:
    """A profile given by a table of heights, as parabolas from row to row, so that it can be
    tilted; straight beyond the ends. InputError where it bends down somewhere.
    """
    left_side, right_side = profile.sides()
    curvatures = np.concatenate([[0.0], left_side.curvature[::-1], right_side.curvature, [0.0]])
    if np.min(curvatures) < -1e-12 * np.max(curvatures):
        raise InputError(
            "profile: under a tilt, or with unequal sides, a table must not bend down anywhere"
        )
    ends_of_parabolas = np.concatenate([-left_side.x[::-1], right_side.x[1:]])
    return PiecewiseParabola(
        knots=ends_of_parabolas,
        curvature=curvatures,
        slope=-float(left_side.slope[-1]),
        height=float(left_side.height[-1]),
        extent=(float(ends_of_parabolas[0]), float(ends_of_parabolas[-1])),
    )


def _convex_power(profile: PowerLaw) -> ConvexProfile:
    """The profile h = rise (|x|/length)^n as a convex curve that can be tilted; a parabola where n
    is 2. InputError for a tip that is too sharp.

    The curve has h', h'' and a quadrature rule that suits its exponent.
    """
    exponent = profile.exponent
    length = profile.length
    height_at_length = profile.rise
    if exponent == 2:
        return _parabolas([0.0], [2 * height_at_length / length**2] * 2, 0.0)
    if exponent < _SHARPEST:
        raise InputError(
            f"profile.exponent = {exponent:.6g}: under bulk stress or tilt half-plane theory takes"
            f" exponents from {_SHARPEST}; a wedge with a rounded tip has kind = 'wedge'"
        )

    def derivative(derivative_order: int, x: Array) -> Array:
        factor = (
            height_at_length
            / length**derivative_order
            * math.prod(exponent - k for k in range(derivative_order))
        )
        relative_distance = np.abs(x) / length
        power_of_distance = np.where(relative_distance > 0, relative_distance, 1.0) ** (
            exponent - derivative_order
        )
        return np.asarray(
            factor * np.sign(x) ** derivative_order * power_of_distance * (relative_distance > 0)
        )

    # A high power is a peak at the end: with the usual steps |x|^20 would lose 2e-10 of the load,
    # with these 1e-13.
    quadrature_rule = ROOTS if exponent <= 4 else logistic(-36.0, 36.0, 0.45 / exponent**0.2)
    return CurvedProfile(
        knots=np.zeros(1),
        size=length,
        height=profile.height,
        gradient=partial(derivative, 1),
        bend=partial(derivative, 2),
        rule=quadrature_rule,
        exponent=exponent,
    )


def _convex_polynomial(profile: EvenPolynomial) -> ConvexProfile:
    """The profile h = sum of c_k (x/length)^(2 k) as a convex curve that can be tilted. InputError
    where it bends down somewhere.

    The curve has h', h'' and a quadrature rule that is exact for its degree.
    """
    length = profile.length
    coefficients_of_squares = np.array(profile.rises)
    if not np.any(coefficients_of_squares[1:]):
        return _parabolas([0.0], [2 * float(coefficients_of_squares[0]) / length**2] * 2, 0.0)
    k = np.arange(1.0, len(coefficients_of_squares) + 1)
    squared_ratio_at_fall = first_fall(k * (2 * k - 1) * coefficients_of_squares)
    if squared_ratio_at_fall is not None:
        raise _bends_down(length * math.sqrt(squared_ratio_at_fall))
    coefficients_of_powers = np.zeros(2 * len(coefficients_of_squares) + 1)
    coefficients_of_powers[2::2] = coefficients_of_squares
    height = Polynomial(coefficients_of_powers, domain=[-length, length])
    # Equal steps of theta are exact for polynomials of twice as many degrees.
    n_nodes = len(coefficients_of_squares) + 2
    nodes = (np.arange(n_nodes) + 0.5) / n_nodes
    quadrature_rule = LogisticRule(nodes, nodes[::-1], np.full(n_nodes, 1 / n_nodes))
    return CurvedProfile(
        np.zeros(0), length, height, height.deriv(), height.deriv(2), quadrature_rule
    )


def _convex_function(profile: CallableProfile) -> ConvexProfile:
    """A profile given by a Python function as a convex curve that can be tilted. InputError where
    it bends down somewhere within its extent.

    Bending is looked for at a thousand places, denser towards the middle. Corners of the slope
    become knots of the curve.
    """
    least_distance = profile.extent * 1e-15

    def bend(x: Array) -> Array:
        distance = np.maximum(np.abs(x), least_distance)
        return np.asarray(profile.bend(distance) / distance)

    sample_places = np.unique(np.linspace(0, 1, 1001)[1:-1] ** 2 * profile.extent)
    falling_places = sample_places[bend(sample_places) < -1e-7 * np.max(bend(sample_places))]
    if len(falling_places):
        raise _bends_down(float(falling_places[0]))
    corners = np.array(_corners(profile))
    return CurvedProfile(
        knots=np.unique(np.concatenate([-corners, [0.0], corners])),
        size=profile.extent / 4,
        height=profile.height,
        gradient=lambda x: np.sign(x) * profile.slope(np.abs(x)),
        bend=bend,
        exponent=max(profile.exponent, _SHARPEST),
        extent=(-profile.extent, profile.extent),
        noise=1e-11,
    )


# Exponent below which a tip is a sharp wedge: what quadratures leave out next to it is too much.
_SHARPEST = 1.01


def _parabolas(knots: list[float], bends: list[float], inner_curvature: float) -> PiecewiseParabola:
    """Symmetric: h'' between and beyond the knots, `inner_curvature` where h' at the first knot,
    -b inner, follows from it.
    """
    b = -knots[0]
    return PiecewiseParabola(
        np.array(knots), np.array(bends), -b * inner_curvature, b * b * inner_curvature / 2
    )


def _bends_down(x: float) -> InputError:
    return InputError(
        f"profile: it bends down near x = {x:.6g}: under bulk stress or tilt half-plane theory"
        " takes profiles that bend down nowhere; finite elements take others too"
    )


# Of ln d between two places at which an inverse is known, and how far they reach beside the unit of
# length.
_STEP = 0.05
_BELOW = 1e-22
_ABOVE = 1e15
# Of ln d: the next step of Newton's method would be about the square of this one, less than
# round-off.
_STILL = 3e-9


def inverse_of(
    load: Function, stiffness: Function, unit: float, corner: float = 0.0, extent: float = math.inf
) -> Function:
    """The inverse d(P) of a rising contact law P(d), to round-off: advance d of the contact edge
    from the load.

    Newton's method between the logarithms of both, started from a tabulated cubic through P and
    dP/dd.

    Parameters
    ----------
    load, stiffness
        P and dP/dd as functions of arrays d [length]
    unit
        a length of the profile; from 1e-22 to 1e15 of it, `extent` at most, the cubic is tabulated,
        beyond P is a power of d
    corner
        an advance at which P is less smooth
    extent
        largest d

    Examples
    --------
    >>> float(inverse_of(lambda d: d**3, lambda d: 3 * d**2, 1.0)(np.array(8.0)))
    2.0
    """

    @cache
    def table() -> _LogTable:
        return _log_table(load, stiffness, unit, corner, extent)

    def advance(loads: Array) -> Array:
        """Advance d of the contact edge under each of the `loads` [length], 0 where a load is not
        positive.

        Newton's rule in logarithms of load and d. Where a step leaves the bracket [least_d,
        largest_d] the bracket is halved instead.
        """
        positive_loads = np.where(loads > 0, loads, 1.0)
        d, least_d, largest_d = table().start(np.log(positive_loads))
        for _ in range(60):
            load_at_d = load(d)
            least_d = np.where(load_at_d < positive_loads, d, least_d)
            largest_d = np.where(load_at_d < positive_loads, largest_d, d)
            with np.errstate(divide="ignore", invalid="ignore"):
                log_step = np.log(positive_loads / load_at_d) * load_at_d / (d * stiffness(d))
            newton_d = d * np.exp(np.clip(log_step, -1.0, 1.0))
            is_in_bracket = (newton_d >= least_d) & (newton_d <= largest_d)
            d = np.where(is_in_bracket, newton_d, np.sqrt(least_d * largest_d))
            if np.all((np.abs(log_step) < _STILL) | (largest_d <= least_d * (1 + 1e-15))):
                break
        return np.where(loads > 0, d, 0.0)

    return advance


class _LogTable(NamedTuple):
    """An inverse at places (n,): ln P, d, the cubic of ln d over ln P and its slopes."""

    log_load: Array
    advance: Array
    cubic: scipy.interpolate.CubicHermiteSpline
    slope: Array

    def start(self, log_load: Array) -> tuple[Array, Array, Array]:
        """First guess of the inverse d(P) at the logarithms of loads, and bounds of d from below
        and above.

        By a cubic of ln d over ln P; beyond the ends of the table d is a power of the load.
        """
        log_below = np.minimum(log_load - self.log_load[0], 0.0)
        log_above = np.maximum(log_load - self.log_load[-1], 0.0)
        log_d = self.cubic(log_load - log_below - log_above)
        d = np.exp(log_d + self.slope[0] * log_below + self.slope[-1] * log_above)
        row_below = np.searchsorted(self.log_load[1:-1], log_load)
        is_in_table = log_below == log_above
        least_d = np.where(is_in_table, self.advance[row_below], d / 2)
        largest_d = np.where(is_in_table, self.advance[row_below + 1], d * 2)
        return d, least_d, largest_d


def _log_table(
    load: Function, stiffness: Function, unit: float, corner: float, extent: float
) -> _LogTable:
    """Table of the inverse d(P) of a rising law P = load(d), dP/dd = stiffness(d): a cubic of ln d
    over ln P.

    The slopes of the cubic are limited so that it rises everywhere.

    Parameters
    ----------
    unit
        a d of the size that is asked for: the table covers so many decades below and above it
    corner
        a d at which the law is not smooth, which is a row of the table
    extent
        largest d
    """
    largest_d = min(_ABOVE * unit, extent)
    logs = np.arange(math.log(_BELOW * unit), math.log(largest_d), _STEP)
    d = np.append(np.exp(logs), [corner, extent])
    d = np.unique(d[(d > 0) & np.isfinite(d)])
    with np.errstate(all="ignore"):
        loads = load(d)
        usable_numbers = np.flatnonzero((loads > 1e-290) & (loads < 1e290))
        log_loads, first_numbers = np.unique(np.log(loads[usable_numbers]), return_index=True)
        d = d[usable_numbers[first_numbers]]
        slopes = np.exp(log_loads) / (d * stiffness(d))
        chords = np.diff(np.log(d)) / np.diff(log_loads)
    # As long as no slope is more than three times a chord beside it the cubic rises.
    least_chords = np.minimum(np.append(chords, np.inf), np.append(np.inf, chords))
    slopes = np.fmin(slopes, 3 * least_chords)
    cubic = scipy.interpolate.CubicHermiteSpline(log_loads, np.log(d), slopes)
    return _LogTable(log_loads, d, cubic, slopes)


# --- power laws and their sums


def load_factor(exponent: float) -> float:
    """The factor by which the Abel transform turns x^n into a load, n = `exponent`: int_0^(pi/2)
    sin(theta)^n d theta = (sqrt(pi)/2) Gamma((n+1)/2)/Gamma(n/2+1).

    >>> round(load_factor(1.0), 15), round(load_factor(2.0), 15)  # 1 and pi/4
    (1.0, 0.785398163397448)
    """
    upper_argument = (exponent + 1) / 2
    lower_argument = exponent / 2 + 1
    if exponent >= 300:  # each Gamma overflows, their quotient does not
        return (
            math.sqrt(math.pi)
            / 2
            * math.exp(math.lgamma(upper_argument) - math.lgamma(lower_argument))
        )
    return math.sqrt(math.pi) / 2 * (math.gamma(upper_argument) / math.gamma(lower_argument))


def power_law(modulus: float, exponent: float, length: float, rise: float) -> ContactLaw:
    """Contact law of h = rise (|x|/length)^n, n = `exponent` >= 1 real: P = K (a/length)^n, K = E*
    n rise load_factor(n), E* = `modulus`.

    >>> law = power_law(modulus=100.0, exponent=2.0, length=1.0, rise=0.5)  # Hertz with R = 1
    >>> round(float(law.advance(np.array(25 * np.pi))), 12)
    1.0
    """
    load_at_length = modulus * exponent * rise * load_factor(exponent)
    return ContactLaw(
        load=lambda a: load_at_length * np.power(a / length, exponent),
        advance=lambda load: length * np.power(load / load_at_length, 1 / exponent),
        stiffness=lambda a: exponent * load_at_length / length * np.power(a / length, exponent - 1),
        power=exponent,
    )


def even_polynomial(modulus: float, length: float, rises: tuple[float, ...]) -> ContactLaw:
    """Contact law P(a) of the profile h = sum c_k (x/length)^(2 k), c_k = `rises` [length]: the sum
    of the loads of its powers. `modulus` is E*.

    Raises
    ------
    InputError
        Where dP/da < 0 somewhere: the contact would split.

    Examples
    --------
    >>> law = even_polynomial(modulus=100.0, length=1.0, rises=(0.5,))  # Hertz with R = 1
    >>> round(float(law.advance(np.array(25 * np.pi))), 12)
    1.0
    """
    k = np.arange(1.0, len(rises) + 1)
    loads_of_terms = (
        modulus * 2 * k * np.array(rises) * np.array([load_factor(2 * power) for power in k])
    )
    # dP/da over a is a polynomial in a^2.
    squared_ratio_at_fall = first_fall(loads_of_terms * k)
    if squared_ratio_at_fall is not None:
        half_width = length * float(np.sqrt(squared_ratio_at_fall))
        raise InputError(
            f"profile: the contact would split near a half-width of {half_width:.6g}; half-plane"
            " theory here needs one contact"
        )
    first_term = int(np.flatnonzero(loads_of_terms > 0)[0])

    def load(a: Array) -> Array:
        squared_ratio = np.square(a / length)
        return np.asarray(squared_ratio * polynomial.polyval(squared_ratio, loads_of_terms))

    def stiffness(a: Array) -> Array:
        ratio = a / length
        return np.asarray(
            2 * ratio / length * polynomial.polyval(ratio * ratio, loads_of_terms * k)
        )

    has_several_terms = sum(rise != 0 for rise in rises) > 1
    return ContactLaw(
        load,
        inverse_of(load, stiffness, length),
        stiffness,
        power=2.0 * (first_term + 1),
        bends_anywhere=has_several_terms,
    )


# --- flat and rounded


# Below this tau the closed form of F cancels.
_SHALLOW = 0.3
_K = np.arange(1.0, 17.0)
_F_SERIES = -((-1.0) ** _K) * 2 / (4 * _K**2 - 1)


def load_function(tau: ArrayLike) -> Array:
    """F(tau) = (1 + tau^2) arctan(tau) - tau to full relative accuracy: the load of a flat face
    with rounded edges, tau = sqrt(a^2 - b^2)/b, divided by E* b^2/(2 R).

    For small tau, where the closed form loses digits, by the series 2 tau^3/3 - 2 tau^5/15 + ...

    >>> round(float(load_function(1.0)), 12)  # pi/2 - 1
    0.570796326795
    """
    t = np.asarray(tau, dtype=float)
    closed_form = (1 + t * t) * np.arctan(t) - t
    is_shallow = t < _SHALLOW
    if not np.any(is_shallow):
        return closed_form
    shallow_tau = np.minimum(t, _SHALLOW)
    squared_tau = shallow_tau * shallow_tau
    series_value = np.full(np.shape(t), _F_SERIES[-1])
    for coefficient in _F_SERIES[-2::-1].tolist():
        series_value = series_value * squared_tau + coefficient
    return np.where(is_shallow, series_value * shallow_tau * squared_tau, closed_form)


def flat_and_rounded(modulus: float, radius: float, flat_half_length: float) -> ContactLaw:
    """Contact law P(a) of a flat face of half-length b with parabolic edges of radius R
    (Ciavarella, Hills and Monno 1998). `modulus` is E*.

        P = (E* b^2/(2 R)) F(tau),  dP/da = (E*/R) a arctan(tau),  tau = sqrt(a^2 - b^2)/b

    F is `load_function`; tau is tan(angle) where that paper has cos(angle) = b/a.

    >>> law = flat_and_rounded(modulus=2.0, radius=1.0, flat_half_length=1.0)
    >>> round(float(law.load(np.sqrt(2.0) - 1)), 12)  # tau = 1
    0.570796326795
    """
    b = flat_half_length
    load_unit = modulus * b**2 / (2 * radius)

    def tau(d: Array) -> Array:
        return np.sqrt(d / b * (2 + d / b))

    def load(d: Array) -> Array:
        return load_unit * load_function(tau(d))

    def stiffness(d: Array) -> Array:
        return modulus / radius * (b + d) * np.arctan(tau(d))

    return ContactLaw(load, inverse_of(load, stiffness, b), stiffness, least_half_width=b)


# --- two curvatures


def two_curvatures(
    modulus: float, inner_radius: float, outer_radius: float, inner_half_length: float
) -> ContactLaw:
    """Contact law P(a) of a profile with h'' = 1/R1 up to x = b = `inner_half_length` and 1/R2
    beyond; R2 infinite makes a wedge with a rounded tip. `modulus` is E*.

    Hertz up to a = b, then with t = sqrt(a^2 - b^2) and F of `load_function`

        P = (E*/(2 R1)) [b t + a^2 arcsin(b/a)] + (E* b^2/(2 R2)) F(t/b),
        dP/da = E* a [arcsin(b/a)/R1 + arccos(b/a)/R2]

    Both terms grow: all digits are kept from R2/R1 = 0 to infinity.

    >>> law = two_curvatures(
    ...     modulus=100.0, inner_radius=1.0, outer_radius=1.0, inner_half_length=0.3
    ... )
    >>> round(float(law.advance(np.array(25 * np.pi))), 12)  # Hertz
    1.0
    """
    b = inner_half_length
    tip_modulus = modulus / inner_radius
    outer_load = modulus / outer_radius * b * b / 2

    def load(a: Array) -> Array:
        end = np.minimum(a, b)
        t = np.sqrt((a - end) * (a + end))
        return tip_modulus / 2 * (
            end * t + a * a * np.arctan2(end, t)
        ) + outer_load * load_function(t / b)

    def stiffness(a: Array) -> Array:
        end = np.minimum(a, b)
        t = np.sqrt((a - end) * (a + end))
        return a * (tip_modulus * np.arctan2(end, t) + modulus / outer_radius * np.arctan2(t, end))

    return ContactLaw(load, inverse_of(load, stiffness, b, b), stiffness, breaks=(b,))


# --- measured rows

# Pieces whose knots are summed one by one.
_TOGETHER = 32


@dataclass(frozen=True, eq=False)
class _Series:
    """Chebyshev series of P and dP/da on pieces [low, high] (n,) of u = sqrt(a - begin); `edges`
    (n,) are the half-widths at which the pieces begin.
    """

    begin: Array
    low: Array
    high: Array
    edges: Array
    load: Powers
    rate: Powers

    def on(self, piece_number: Indices, u: Array, values: Powers) -> Array:
        """Value of one of the two at u on pieces of these numbers."""
        low = self.low[piece_number]
        high = self.high[piece_number]
        return values(piece_number, np.minimum((2 * u - low - high) / (high - low), 1.0))

    def sample_half_widths(self) -> Array:
        """Half-widths at the nodes and both ends of every piece, (n, nodes): where dP/da falls
        behind a knot it is least at the next one.
        """
        node = np.concatenate([[-1.0], NODES, [1.0]])
        u = self.low[:, None] + (self.high - self.low)[:, None] * (1 + node) / 2
        return np.asarray(self.begin[:, None] + np.square(u))


def tabulated(modulus: float, profile: Tabulated) -> ContactLaw:
    """Contact law P(a) of a profile given by rows of x and h: its curvature kappa is constant
    between knots b_j, so that P and dP/da are sums of flats with rounded edges. `modulus` is E*.

        dP/da = E* a [kappa_0 pi/2 + sum over b_j < a of (kappa_j - kappa_(j-1)) arccos(b_j/a)]

    The sums (the Abel transform of the table) are taken once, at the nodes of Chebyshev series in
    sqrt(a - b_j) behind each knot; up to the second knot all is in closed form.

    Raises
    ------
    InputError
        For rows under which the contact would split, with the row and what to do; later for a load
        that needs a wider table.

    Examples
    --------
    >>> rows = [(0.1 * k, (0.1 * k) ** 2 / 2) for k in range(11)]  # Hertz with R = 1
    >>> round(
    ...     float(tabulated(100.0, Tabulated(points=rows)).load(np.array(0.6))) / np.pi, 9
    ... )  # 25 a^2
    9.0
    """
    spline = profile.spline()
    first_knot = int(np.flatnonzero(spline.curvature > 0)[0])
    knots = spline.x[first_knot:]
    curvature_stiffness = modulus * spline.curvature[first_knot:]
    least_width = float(knots[0])
    extent = float(knots[-1])
    # The first piece is Hertz, or flat and rounded with 1/R the first curvature.
    first_piece = (
        flat_and_rounded(curvature_stiffness[0], 1.0, least_width)
        if least_width > 0
        else power_law(curvature_stiffness[0], 2.0, 1.0, 0.5)
    )
    law = _LawOfRows(first_piece, _series_of_rows(knots, curvature_stiffness), least_width)
    largest_load = float(law.load(np.array(extent - least_width)))
    inverse = first_piece.advance
    if law.has_series:
        corner = float(knots[1]) - least_width
        inverse = inverse_of(law.load, law.stiffness, extent, corner, extent - least_width)

    def advance(loads: Array) -> Array:
        needed_load = float(np.max(loads, initial=0.0))
        if needed_load > largest_load:
            raise ProfileDataError(
                f"profile: the normal load {needed_load:.6g} needs a contact wider than the table,"
                f" whose last x = {extent:.6g} carries {largest_load:.6g}"
            )
        return np.asarray(inverse(loads))

    if law.has_series:
        half_width = law.row_series.sample_half_widths()
        rate = law.stiffness(half_width - least_width)
        # Round-off may leave that much below 0 where the profile is straight.
        falls = rate < -1e-12 * np.max(rate)
        if np.any(falls):
            raise _splits(profile, float(np.min(half_width[falls])))
    inner_knots = tuple(knots[1:-1].tolist())
    return ContactLaw(law.load, advance, law.stiffness, least_width, inner_knots, extent=extent)


class _LawOfRows(NamedTuple):
    """P and dP/da of a table of rows: by series in the half-width, but for the first piece, which
    has a closed form.

    Attributes
    ----------
    first_piece
        law of the contact up to the second knot, Hertz or flat and rounded
    row_series
        Chebyshev series of P and dP/da behind every knot from the second on
    least_width
        contact half-width without load [length]
    """

    first_piece: ContactLaw
    row_series: _Series
    least_width: float

    @property
    def has_series(self) -> bool:
        """Whether the table has more than two knots."""
        return len(self.row_series.begin) > 0

    def load(self, d: Array) -> Array:
        """P at advances d of the edge [force per thickness]."""
        return self._value(d, self.row_series.load, self.first_piece.load)

    def stiffness(self, d: Array) -> Array:
        """dP/da at advances d of the edge [stress]."""
        return self._value(d, self.row_series.rate, self.first_piece.stiffness)

    def _value(
        self, d: Array, values: Powers, law_of_first_piece: Callable[[Array], Array]
    ) -> Array:
        """P or dP/da at advances d of the edge of contact beyond the half-width without load.

        Parameters
        ----------
        values
            the series of P or of dP/da, for half-widths behind the second knot
        law_of_first_piece
            closed form of it in d, for half-widths before that knot
        """
        row_series = self.row_series
        if not self.has_series:
            return law_of_first_piece(d)
        half_widths = d + self.least_width
        piece_number = np.searchsorted(row_series.edges, half_widths, side="right") - 1
        root_distances = np.sqrt(np.maximum(half_widths - row_series.begin[piece_number], 0.0))
        values_at_widths = row_series.on(np.maximum(piece_number, 0), root_distances, values)
        is_in_first_piece = piece_number < 0
        if np.any(is_in_first_piece):
            # of d itself, which keeps its digits beside a flat
            values_at_widths[is_in_first_piece] = law_of_first_piece(d[is_in_first_piece])
        return values_at_widths


class _Piece(NamedTuple):
    """A piece [low, high] of u = sqrt(a - begin), behind the knot at `begin`."""

    begin: float
    low: float
    high: float


class _Range(NamedTuple):
    """Pieces `first` to `last` of a table, whose sums over the knots below `known` are taken.

    `smooth` (nodes, 2) are the series of these sums, of P and of dP/da/a, in a on `ends`.
    """

    first: int
    last: int
    known: int
    ends: tuple[float, float]
    smooth: Array


def _pieces_of_rows(knots: Array) -> list[_Piece]:
    """Ranges of the contact half-width a that one Chebyshev series each can serve, behind every
    knot of a table from the second on.

    A range is given in u = sqrt(a - knot), in which P is smooth there. A short first one is
    followed by octaves: what the knot before leaves is singular at a distance in u^2 below 0.
    `knots` (k,) are half- widths at which the curvature of the profile jumps.
    """
    pieces: list[_Piece] = []
    for knot_before, begin, end in zip(
        knots[:-2].tolist(), knots[1:-1].tolist(), knots[2:].tolist(), strict=True
    ):
        length = (end - begin) ** 0.5
        first_length = (begin - knot_before) ** 0.5
        octaves = range(math.ceil(math.log2(length / first_length)))
        ends_of_pieces = [0.0, *(first_length * 2.0**k for k in octaves), length]
        if len(ends_of_pieces) > 2 and length - ends_of_pieces[-2] < 0.1 * (
            ends_of_pieces[-2] - ends_of_pieces[-3]
        ):
            del ends_of_pieces[-2]
        pieces += [_Piece(begin, begin_u, end_u) for begin_u, end_u in pairwise(ends_of_pieces)]
    return pieces


class _KnotSums(NamedTuple):
    """P and dP/da of a table as sums over its knots, each a flat punch with rounded edges.

    Attributes
    ----------
    knots
        (k,) half-widths at which the curvature h'' of the profile jumps, ascending
    jumps
        (k,) jumps of E* h'' there
    """

    knots: Array
    jumps: Array

    def over_knots(
        self, a: Array, begin_of_piece: Array, distances: Array, numbers: slice
    ) -> Array:
        """P and dP/da/a of the knots of these numbers at contact half-widths a, the last axis
        being the two.

            P = (1/2) sum over b < a of jump (a^2 arccos(b/a) - b sqrt(a^2 - b^2)),
            dP/da = a sum of jump arccos(b/a)

        a is `begin_of_piece` + `distances`, so that a - b is known without cancellation; all three
        have a last axis of length 1.
        """
        b = self.knots[numbers]
        distance_from_knots = np.maximum((begin_of_piece - b) + distances, 0.0)
        tau = np.sqrt(distance_from_knots * (a + b))
        angle = np.where(distance_from_knots > 0, np.arctan2(tau, b), 0.0)
        twice_load = np.where(distance_from_knots > 0, a * a * angle - b * tau, 0.0)
        load = twice_load @ self.jumps[numbers] / 2
        rate_over_width = angle @ self.jumps[numbers]
        return np.stack([load, rate_over_width], axis=-1)

    def with_far_knots(self, range_before: _Range, range_ends: tuple[float, float]) -> _Range:
        """A range of half-widths whose smooth part has taken in more knots: those farther below
        the range than it is long.

        Their sums are smooth on the range: one Chebyshev series holds them, with those of the
        knots that the wider `range_before` had taken in. `range_ends` are the least and the
        largest half-width of the range.
        """
        length = range_ends[1] - range_ends[0]
        places = range_ends[0] + length * (1 + NODES) / 2
        far_knots = int(np.searchsorted(self.knots, 2 * range_ends[0] - range_ends[1]))
        known = max(far_knots, range_before.known)
        place_in_series = (places - range_before.ends[0]) * (
            2 / (range_before.ends[1] - range_before.ends[0])
        ) - 1
        sums_at_places = chebyshev.chebval(place_in_series, range_before.smooth).T
        column_of_places = places[:, None]
        sums_at_places = sums_at_places + self.over_knots(
            column_of_places,
            column_of_places,
            np.zeros((1, 1)),
            slice(range_before.known, known),
        )
        smooth = series(sums_at_places.T).T
        return _Range(range_before.first, range_before.last, known, range_ends, smooth)


def _series_of_rows(knots: Array, curvature_stiffness: Array) -> _Series:
    """Chebyshev series of P(a) and dP/da behind every knot b of a table of heights, from the second
    knot on; none where there are no more than two.

    Both are sums over all knots below a. Sums over knots that are farther below a range of
    half-widths than it is long are smooth there: one series serves for all of the range. Halves of
    the range then add knots that are farther than they are long themselves. So the time grows as
    the number of rows, not as its square. What is left in the end is summed knot by knot.

    Parameters
    ----------
    knots
        (k,) half-widths at which h'' jumps, ascending
    curvature_stiffness
        (k,) E* h'' behind each knot [stress/length]
    """
    pieces = _pieces_of_rows(knots)
    begin_of_pieces = np.array([piece.begin for piece in pieces])
    begin_root = np.array([piece.low for piece in pieces])
    end_root = np.array([piece.high for piece in pieces])
    # The ends too: loads there are where pieces begin and end.
    node = np.concatenate([[-1.0], NODES, [1.0]])
    root_of_distance = begin_root[:, None] + (end_root - begin_root)[:, None] * (1 + node) / 2
    distances = np.square(root_of_distance)
    half_widths = begin_of_pieces[:, None] + np.square(root_of_distance)
    load_and_rate = np.zeros((*half_widths.shape, 2))
    sums = _KnotSums(knots, np.diff(curvature_stiffness, prepend=0.0))

    ranges: list[_Range] = []
    if pieces:
        ranges.append(_Range(0, len(begin_of_pieces), 0, (0.0, 1.0), np.zeros((len(NODES), 2))))
    while ranges:
        range_before = ranges.pop()
        range_ends = (half_widths[range_before.first, 0], half_widths[range_before.last - 1, -1])
        range_of_pieces = sums.with_far_knots(range_before, range_ends)
        if range_of_pieces.last - range_of_pieces.first > _TOGETHER:
            middle = (range_of_pieces.first + range_of_pieces.last) // 2
            ranges.append(range_of_pieces._replace(last=middle))
            ranges.append(range_of_pieces._replace(first=middle))
            continue
        numbers = slice(range_of_pieces.first, range_of_pieces.last)
        knots_reached = int(np.searchsorted(knots[:-1], range_ends[1]))
        range_length = range_ends[1] - range_ends[0]
        place_in_series = (half_widths[numbers] - range_ends[0]) * 2 / range_length - 1
        far_sums = chebyshev.chebval(place_in_series, range_of_pieces.smooth)
        load_and_rate[numbers] = np.moveaxis(far_sums, 0, -1)
        load_and_rate[numbers] += sums.over_knots(
            half_widths[numbers, :, None],
            begin_of_pieces[numbers, None, None],
            distances[numbers, :, None],
            slice(range_of_pieces.known, knots_reached),
        )
    load = load_and_rate[..., 0]
    rate = load_and_rate[..., 1] * half_widths
    return _Series(
        begin_of_pieces,
        begin_root,
        end_root,
        edges=begin_of_pieces + begin_root * begin_root,
        load=Powers(series(load[:, 1:-1]).T),
        rate=Powers(series(rate[:, 1:-1]).T),
    )


def _splits(profile: Tabulated, half_width: float) -> InputError:
    """The error message for a table of heights under which the contact would split near a
    `half_width`: the row, the cause and what to do.

    Heights that are written with few digits rise by stairs; no engine has an answer for those.
    """
    row = profile.row_before(half_width)
    step = profile.step_of_heights()
    x, h = profile.points.values[row].tolist()
    cause = "the curve through the rows bends down there"
    advice = "smooth the rows until it does not"
    if step is not None:
        cause = (
            f"h is written in steps of {step:.6g}, and the curve through such rows goes up by"
            " stairs"
        )
        advice = (
            "write h with more digits, leave rows out until each rises by many steps, or give a"
            " formula that fits them"
        )
    place = f"{profile.place(row)}, x = {x:.6g} and h = {h:.6g}"
    message = (
        f"{place}: the contact would split near a half-width of {half_width:.6g}: {cause}; {advice}"
    )
    return InputError(message) if step is None else ProfileDataError(message)


# --- Python functions


# Octaves of a half-width that have series; below them P is a power of a.
_OCTAVES = 54


@dataclass(frozen=True, eq=False)
class _Stretch:
    """P and dP/da between two corners as functions of a distance u: u = a - begin from the middle,
    else u^2 = a - begin.

    Behind a corner of the profile, and beside a flat, both are smooth functions of the root only.
    """

    begin: float
    rooted: bool
    loads: Pieces
    rates: Pieces

    @property
    def power(self) -> float:
        """Power of u that P follows below the least octave."""
        first_edge = np.array(self.loads.edges[0])
        return float(
            first_edge
            * self.rates(first_edge)
            / self.loads(first_edge)
            * (2 * first_edge if self.rooted else 1.0)
        )

    def at(self, u: Array, derivative_order: int) -> Array:
        """P (order 0) or dP/da (1); below the least octave as a power."""
        pieces = (self.loads, self.rates)[derivative_order]
        first_edge = float(pieces.edges[0])
        values_inside = pieces(np.maximum(u, first_edge))
        if first_edge == 0:
            return values_inside
        # of dP/da of a sharp wedge 0, to round-off
        power = max(self.power - derivative_order * (2 if self.rooted else 1), 0.0)
        return values_inside * np.minimum(u / first_edge, 1.0) ** power


def slope_function(modulus: float, profile: CallableProfile) -> ContactLaw:
    """Contact law P(a) of a profile whose slope h'(x) is a Python function: P and dP/da by
    quadrature, kept as piecewise Chebyshev series. `modulus` is E*.

    Raises
    ------
    InputError
        For a profile under which the contact would split; later for a load that needs a wider
        contact than `extent`.

    Examples
    --------
    >>> law = slope_function(
    ...     100.0, CallableProfile(slope_function=lambda x: x, extent=2.0)
    ... )  # Hertz with R = 1
    >>> round(float(law.advance(np.array(25 * np.pi))), 12)
    1.0
    """
    corners = _corners(profile)
    least_width = _flat_half_length(profile, corners)
    begins_of_stretches = [least_width, *(b for b in corners if least_width < b < profile.extent)]
    ranges = list(pairwise([*begins_of_stretches, profile.extent]))
    cuts_behind = tuple(reversed(begins_of_stretches if least_width else begins_of_stretches[1:]))
    stretches = [_stretch(modulus, profile, begin, end, cuts_behind) for begin, end in ranges]
    largest_load = float(stretches[-1].loads(stretches[-1].loads.edges[-1]))

    value_at = partial(_value_on_stretches, stretches, least_width)
    inverse = inverse_of(
        partial(value_at, derivative_order=0),
        partial(value_at, derivative_order=1),
        profile.extent,
        extent=profile.extent - least_width,
    )

    def advance(loads: Array) -> Array:
        needed_load = float(np.max(loads, initial=0.0))
        if needed_load > largest_load * (1 + 1e-12):
            raise ProfileDataError(
                f"profile.extent = {profile.extent:.6g}: the normal load {needed_load:.6g} needs a"
                f" wider contact, the extent carries {largest_load:.6g}"
            )
        return inverse(loads)

    sample_half_widths = np.unique(
        np.concatenate([np.linspace(begin, end, 200) for begin, end in ranges])
    )
    sample_rates = value_at(sample_half_widths - least_width, 1)
    falls = sample_rates < -1e-10 * np.max(sample_rates)
    if np.any(falls):
        first_fall_width = sample_half_widths[falls][0]
        raise InputError(
            f"profile: the contact would split near a half-width of {first_fall_width:.6g}"
        )
    return ContactLaw(
        load=partial(value_at, derivative_order=0),
        advance=advance,
        stiffness=partial(value_at, derivative_order=1),
        least_half_width=least_width,
        breaks=tuple(begins_of_stretches[1:]),
        power=stretches[0].power if not least_width else 2.0,
        extent=profile.extent,
        bends_anywhere=True,
        # A derivative was taken of h', and two of h.
        noise=max(1e-11, profile.rounding_of_height.stiffness),
    )


def _value_on_stretches(
    stretches: list[_Stretch], least_width: float, d: Array, derivative_order: int
) -> Array:
    """P (order 0) or dP/da (order 1) of a contact whose edge is d beyond the half-width without
    load, `least_width`.

    The stretches between the corners of the profile hold series of both, ascending.
    """
    half_width = least_width + d
    values = np.zeros(d.shape)
    begins = [stretch.begin for stretch in stretches]
    stretch_number = np.maximum(np.searchsorted(begins, half_width, side="right") - 1, 0)
    for k, stretch in enumerate(stretches):
        in_stretch = stretch_number == k
        if np.any(in_stretch):
            # d itself has more digits beside a flat.
            distance = (d if k == 0 else half_width - stretch.begin)[in_stretch]
            series_argument = np.sqrt(distance) if stretch.rooted else distance
            values[in_stretch] = stretch.at(series_argument, derivative_order)
    return values


def _stretch(
    modulus: float, profile: CallableProfile, begin: float, end: float, cuts: tuple[float, ...]
) -> _Stretch:
    """Chebyshev series of P and dP/da for contact half-widths between two corners of a profile,
    begin < a < end, by quadrature of its slope.

    The series run in u = a - begin, or in u = sqrt(a - begin) behind a corner, where P is smooth in
    the root only. The first ranges of u are octaves.

    Parameters
    ----------
    modulus
        E* [stress]
    cuts
        places where the slope has corners, descending [length]

    Raises
    ------
    InputError
        Where the function of the profile is too rough.
    """
    is_rooted = begin > 0
    length = np.sqrt(end - begin) if is_rooted else end - begin
    edges_of_pieces = length * 0.5 ** np.arange(_OCTAVES - 1, -1.0, -1.0)
    if is_rooted and profile.slope(np.array(begin)) > 0:
        edges_of_pieces = np.concatenate([[0.0], edges_of_pieces[-4:]])
    elif is_rooted:
        edges_of_pieces = edges_of_pieces[edges_of_pieces > 1e-5 * np.sqrt(begin)]

    def integral(u: Array, derivative_order: int) -> Array:
        distance = u**2 if is_rooted else u
        return _abel_integral(modulus, profile, begin, distance, cuts, derivative_order)

    # Beside a flat, or behind a corner, the slope is known to round-off of its largest value and
    # its bend jumps within round-off of the corner: 4e-15 of the scale can be had for the load,
    # 1e-12 for its derivative. From the middle on that is so of every octave by itself. What the
    # values of a height leave uncertain is no more than noise either.
    sample_places = edges_of_pieces[-1:] if is_rooted else edges_of_pieces[1:]
    floors = (
        max(4e-15, profile.rounding_of_height.load),
        max(1e-12, profile.rounding_of_height.stiffness),
    )
    try:
        loads, rates = (
            halved(
                partial(integral, derivative_order=k),
                edges_of_pieces,
                floors[k] / 4e-15 * integral(sample_places, k),
            )
            for k in (0, 1)
        )
    except Unresolved as fault:
        raise InputError(
            f"profile: the function is too rough near x = {fault.high:.6g}: the load that a contact"
            " of this half-width carries is no smooth function; give `breaks`, or a smoother"
            " function"
        ) from fault
    return _Stretch(begin, is_rooted, loads, rates)


def _abel_integral(
    modulus: float,
    profile: CallableProfile,
    begin: float,
    distance: Array,
    cuts: tuple[float, ...],
    derivative_order: int,
) -> Array:
    """Load P (order 0) or stiffness dP/da (order 1) of a contact of half-width a, by quadrature of
    the profile's slope.

        P     = E* a int cos(angle) h'(x) d angle,    x = a cos(angle), 0 < angle < pi/2
        dP/da = E* int cos(angle) (x h')' d angle

    Parameters
    ----------
    modulus
        E* [stress]
    begin, distance
        a = begin + distance: the distance from a corner keeps its digits [length]
    cuts
        places b of corners of the slope, at which the integral is split [length]
    """
    half_width = begin + distance
    distances_to_cuts = [np.maximum(distance + (begin - b), 0.0) for b in cuts]
    angles = [
        np.arctan2(np.sqrt(distance_to_cut * (half_width + b)), b)
        for distance_to_cut, b in zip(distances_to_cuts, cuts, strict=True)
    ]
    nodes = panels(np.zeros(half_width.shape), np.pi / 2, angles)
    cosine = np.sin(np.where(nodes.at < 0.7, np.pi / 2 - nodes.at, nodes.below))
    x = half_width[..., None, None] * cosine
    slopes = (
        profile.slope(x) + profile.bend(x)
        if derivative_order
        else profile.slope(x) * half_width[..., None, None]
    )
    return np.asarray(modulus * np.sum(nodes.weight * cosine * slopes, axis=(-2, -1)))


def _flat_half_length(profile: CallableProfile, corners: tuple[float, ...]) -> float:
    """Half-length of the flat in the middle of a profile given by a function; 0 if there is none.

    A flat ends at one of the `corners` of the slope, ascending, within which the slope is 0. Slopes
    that fall towards 0 without a corner are not flat.
    """
    sample_places = np.array([*profile.corners, profile.extent])
    is_flat_there = profile.slope(sample_places * 0.999) <= 1e-15 * float(
        np.max(profile.slope(sample_places))
    )
    flat_places = sample_places[is_flat_there]
    # Slopes fall towards 0 without being flat: a flat is one whose edge is a corner of the profile.
    inner_corners = [b for b in corners if len(flat_places) and b <= flat_places[-1] * (1 + 1e-9)]
    if not inner_corners:
        return 0.0
    edge_of_flat = inner_corners[-1]
    is_flat = profile.slope(edge_of_flat * 0.9) <= 1e-13 * np.max(profile.slope(sample_places))
    return float(edge_of_flat) if is_flat else 0.0


def _corners(profile: CallableProfile) -> tuple[float, ...]:
    """Distances b at which the curvature jumps: h'' a little on either side differs by more than a
    millionth.
    """
    corners = []
    for b in profile.corners:
        left, right = profile.bend(np.array([b * (1 - 1e-9), b * (1 + 1e-9)]))
        size = abs(left) + abs(right) + float(profile.slope(np.array(b)))
        if abs(left - right) > 1e-6 * size + 1e-300:
            corners.append(b)
    return tuple(corners)


_KINDS: dict[type, _Kind] = {
    Hertz: _Kind(lambda modulus, p, datum: HertzContact(modulus, p.radius, datum), _convex_hertz),
    FlatRounded: _Kind.by_law(
        lambda modulus, p: flat_and_rounded(modulus, p.radius, p.flat_half_length),
        _convex_flat_rounded,
    ),
    PowerLaw: _Kind.by_law(
        lambda modulus, p: power_law(modulus, p.exponent, p.length, p.rise), _convex_power
    ),
    Compound: _Kind.by_law(
        lambda modulus, p: two_curvatures(
            modulus, p.inner_radius, p.outer_radius, p.inner_half_length
        ),
        _convex_compound,
    ),
    Wedge: _Kind.by_law(
        lambda modulus, p: two_curvatures(modulus, p.tip_radius, math.inf, p.tip_half_length),
        _convex_wedge,
    ),
    EvenPolynomial: _Kind.by_law(
        lambda modulus, p: even_polynomial(modulus, p.length, p.rises), _convex_polynomial
    ),
    Tabulated: _Kind.by_law(tabulated, _convex_table),
    CallableProfile: _Kind.by_law(slope_function, _convex_function),
}
"""Each kind of profile: the one place that tells them apart."""
