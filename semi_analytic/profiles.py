"""The contact law P(a) of every profile by the Abel transform of its slope: load, its inverse and
its slope dP/da, and the corners, at which dP/da is not smooth.

# notation: a half-width, a_0 that of no load, d = a - a_0, P normal load per unit thickness, E*
composite modulus, h(x) profile, b half-width at a corner

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
from scenes.chebyshev import (
    CHEBYSHEV_NODES,
    PiecewiseSeries,
    SeriesAsPowers,
    UnresolvedError,
    chebyshev_coefficients,
    piecewise_series_by_halving,
)
from scenes.profiles import place_of_fall
from semi_analytic.elasticity import composite_modulus
from semi_analytic.hertz import HertzContact
from semi_analytic.punch_superposition import ContactLaw, Function, PunchSuperposition
from semi_analytic.quadrature import GRADED_RULE, LogisticRule, logistic_rule, panel_nodes
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
    """Normal contact of a symmetric profile between half-planes of two materials: the contact law
    P(a) of load and half-width, and pressure, approach and slip integrals that follow from it. The
    profile may have a `datum_length` [length], at which rigid movements are measured.

    Raises
    ------
    InputError
        For a kind of profile that this engine does not know, for a table with unequal sides, and
        for a profile under which the contact would split into several.
    """
    # a table of heights on both sides of x = 0
    if isinstance(profile, Tabulated) and not profile.symmetric:
        raise InputError(
            "profile: its two sides are unequal: this takes symmetric profiles, `solve` takes both"
        )
    modulus = composite_modulus(materials)  # E*
    datum_length = getattr(profile, "datum_length", 0.0)
    # the functions for this kind of profile; `contact` makes the normal contact
    return _kind_of(profile).contact(modulus, profile, datum_length)


def convex_profile(profile: Profile) -> ConvexProfile:
    """A profile as a convex curve that can be tilted: its contact in closed form where it is made
    of parabolas, else by quadrature.

    Raises
    ------
    InputError
        For a profile that bends down somewhere: under a tilt its contact may split. For a power
        law with an exponent below 1.01, whose tip is all but a sharp wedge.
    """
    return _kind_of(profile).convex_curve(profile)


class _Kind(NamedTuple):
    """The functions that make contacts of one kind of profile.

    Attributes
    ----------
    contact
        gives the symmetric normal contact for E*, the profile and a datum length
    convex_curve
        gives the profile as a convex curve that can be tilted
    """

    contact: Callable[[float, Any, float], SymmetricContact]
    convex_curve: Callable[[Any], ConvexProfile]

    @classmethod
    def by_law(
        cls, law: Callable[[float, Any], ContactLaw], convex_curve: Callable[[Any], ConvexProfile]
    ) -> _Kind:
        """A kind of profile whose contact is the superposition of flat punches for P(a) = `law`, a
        function of E* and the profile. `convex_curve` makes of the profile a curve that can be
        tilted. E* is the composite modulus.
        """

        def contact(modulus: float, profile: Any, datum_length: float) -> SymmetricContact:
            return PunchSuperposition(law(modulus, profile), datum_length)

        return cls(contact, convex_curve)


def _kind_of(profile: Profile) -> _Kind:
    """The functions that make contacts of profiles of this type; InputError for a type that this
    engine does not know.
    """
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
    """A profile given by a table of heights as a convex curve that can be tilted: parabolas from
    row to row, straight beyond the ends. InputError where it bends down somewhere.
    """
    # Each has ascending x >= 0, counted from the middle, with height, slope and curvature there.
    left_side, right_side = profile.sides()
    # from left to right, 0 beyond both ends
    curvatures = np.concatenate([[0.0], left_side.curvature[::-1], right_side.curvature, [0.0]])
    if np.min(curvatures) < -1e-12 * np.max(curvatures):
        raise InputError(
            "profile: under a tilt, or with unequal sides, a table must not bend down anywhere"
        )
    ends_of_parabolas = np.concatenate([-left_side.x[::-1], right_side.x[1:]])
    return PiecewiseParabola(
        knots=ends_of_parabolas,
        curvature=curvatures,
        slope_at_first_knot=-float(left_side.slope[-1]),
        height_at_first_knot=float(left_side.height[-1]),
        extent=(float(ends_of_parabolas[0]), float(ends_of_parabolas[-1])),
    )


def _convex_power(profile: PowerLaw) -> ConvexProfile:
    """The profile h = rise (|x|/length)^n as a convex curve that can be tilted; a parabola where n
    is 2. InputError for n below 1.01, where the tip is all but a sharp wedge.

    `height` of the profile is h(x). The curve has h, h', h'' and a quadrature rule that suits its
    exponent.
    """
    exponent = profile.exponent
    length = profile.length
    height_at_length = profile.rise
    # one parabola: h'' on both sides of x = 0
    if exponent == 2:
        return _parabolas([0.0], [2 * height_at_length / length**2] * 2, 0.0)
    # _LEAST_EXPONENT_OF_TIP: 1.01
    if exponent < _LEAST_EXPONENT_OF_TIP:
        raise InputError(
            f"profile.exponent = {exponent:.6g}: under bulk stress or tilt half-plane theory takes"
            f" exponents from {_LEAST_EXPONENT_OF_TIP}; a wedge with a rounded tip has kind ="
            " 'wedge'"
        )

    def derivative(derivative_order: int, x: Array) -> Array:
        """h' (`derivative_order` 1) or h'' (2) of h = rise (|x|/length)^n at x of any sign,
        n = `exponent`; 0 at x = 0, also where h'' is not 0, or infinite, there.
        """
        # n (n - 1) ... rise/length^order, the derivative at |x| = length
        derivative_at_length = (
            height_at_length
            / length**derivative_order
            * math.prod(exponent - k for k in range(derivative_order))
        )
        relative_distance = np.abs(x) / length
        power_of_distance = np.where(relative_distance > 0, relative_distance, 1.0) ** (
            exponent - derivative_order
        )
        return np.asarray(
            derivative_at_length
            * np.sign(x) ** derivative_order
            * power_of_distance
            * (relative_distance > 0)
        )

    # A high power is a peak at the end of the contact: with the steps of GRADED_RULE |x|^20 would
    # lose 2e-10 of the load, with these 1e-13.
    quadrature_rule = (
        GRADED_RULE if exponent <= 4 else logistic_rule(-36.0, 36.0, 0.45 / exponent**0.2)
    )
    return CurvedProfile(
        knots=np.zeros(1),
        typical_half_length=length,
        height=profile.height,
        gradient=partial(derivative, 1),
        second_derivative=partial(derivative, 2),
        rule=quadrature_rule,
        exponent=exponent,
    )


def _convex_polynomial(profile: EvenPolynomial) -> ConvexProfile:
    """The profile h = sum of c_k (x/length)^(2 k), k from 1, as a convex curve that can be tilted.
    InputError where it bends down somewhere.

    The rises of the profile are c_k [length]. It is a parabola where c_1 stands alone. Else the
    curve has h, h', h'' and a quadrature rule that is exact for its degree.
    """
    length = profile.length
    coefficients_of_squares = np.array(profile.rises)  # c_k
    # c_1 alone: knots, h'' on each side of them, and h'' between two knots, of which there are none
    if not np.any(coefficients_of_squares[1:]):
        return _parabolas([0.0], [2 * float(coefficients_of_squares[0]) / length**2] * 2, 0.0)
    k = np.arange(1.0, len(coefficients_of_squares) + 1)
    # (x/length)^2 at which h'' is negative, None where it never is
    squared_ratio_at_fall = place_of_fall(k * (2 * k - 1) * coefficients_of_squares)
    if squared_ratio_at_fall is not None:
        raise _bends_down_error(length * math.sqrt(squared_ratio_at_fall))
    # of all powers of x/length, the even ones being c_k
    coefficients_of_powers = np.zeros(2 * len(coefficients_of_squares) + 1)
    coefficients_of_powers[2::2] = coefficients_of_squares
    # h as a polynomial of x, which is scaled to [-1, 1]; `deriv` gives its derivatives
    height_polynomial = Polynomial(coefficients_of_powers, domain=[-length, length])
    # The rule averages over theta, x = middle + half-width cos(theta) of the contact. Its n equal
    # steps, each with the weight 1/n, are exact for polynomials of degree below 2 n. A rule holds
    # distances of its nodes from 0 and from 1, and weights.
    n_nodes = len(coefficients_of_squares) + 2
    nodes = (np.arange(n_nodes) + 0.5) / n_nodes
    quadrature_rule = LogisticRule(nodes, nodes[::-1], np.full(n_nodes, 1 / n_nodes))
    return CurvedProfile(
        knots=np.zeros(0),
        typical_half_length=length,
        height=height_polynomial,
        gradient=height_polynomial.deriv(),
        second_derivative=height_polynomial.deriv(2),
        rule=quadrature_rule,
    )


def _convex_function(profile: CallableProfile) -> ConvexProfile:
    """A profile given by a Python function as a convex curve that can be tilted. InputError where
    it bends down somewhere within its extent.

    h'' is evaluated at a thousand places, denser towards the middle. Corners of the slope become
    knots of the curve. The profile is defined for |x| up to its `extent`. Its `exponent` is n - 1,
    the power of x that the slope follows next to the middle; the height follows |x|^n.
    """
    # far below the nodes next to the middle, 1e-16 of a contact: h'' may grow without limit there
    least_distance = profile.extent * 1e-30

    def second_derivative(x: Array) -> Array:
        """h'' at x of any sign; `curvature_times_x` is x h''."""
        distance = np.maximum(np.abs(x), least_distance)
        return np.asarray(profile.curvature_times_x(distance) / distance)

    sample_places = np.unique(np.linspace(0, 1, 1001)[1:-1] ** 2 * profile.extent)
    sampled_curvatures = second_derivative(sample_places)
    # where h'' is below 0 by more than 1e-7 of the largest
    falling_places = sample_places[sampled_curvatures < -1e-7 * np.max(sampled_curvatures)]
    if len(falling_places):
        raise _bends_down_error(float(falling_places[0]))
    # distances at which h'' jumps
    corner_places = np.array(_corners(profile))
    # n; below 1.01 it counts as that
    exponent_of_height = profile.exponent + 1
    return CurvedProfile(
        knots=np.unique(np.concatenate([-corner_places, [0.0], corner_places])),
        typical_half_length=profile.extent / 4,
        height=profile.height,
        gradient=lambda x: np.sign(x) * profile.slope(np.abs(x)),
        second_derivative=second_derivative,
        exponent=max(exponent_of_height, _LEAST_EXPONENT_OF_TIP),
        extent=(-profile.extent, profile.extent),
        relative_roundoff=1e-11,
    )


# Exponent below which a tip is a sharp wedge: what quadratures leave out next to it is too much.
_LEAST_EXPONENT_OF_TIP = 1.01


def _parabolas(
    knots: list[float], curvatures: list[float], inner_curvature: float
) -> PiecewiseParabola:
    """A symmetric convex profile made of parabolas that join at the `knots` -b and b, or at 0.

    `curvatures` are h'' from left to right, one more than knots. Of two knots `inner_curvature` is
    h'' between them: slope and height at the first follow from it.
    """
    b = -knots[0]
    return PiecewiseParabola(
        np.array(knots), np.array(curvatures), -b * inner_curvature, b * b * inner_curvature / 2
    )


def _bends_down_error(x: float) -> InputError:
    """The error for a profile that bends down near x and so is not convex."""
    return InputError(
        f"profile: it bends down near x = {x:.6g}: under bulk stress or tilt half-plane theory"
        " takes profiles that bend down nowhere; finite elements take others too"
    )


# Step of ln d between two rows of the table of an inverse, and its least and largest d over the
# unit of length.
_LOG_STEP_OF_TABLE = 0.05
_LEAST_RATIO_TO_UNIT = 1e-22
_LARGEST_RATIO_TO_UNIT = 1e15
# Newton's method ends at this step of ln d: the next would be about its square, less than
# round-off.
_CONVERGED_LOG_STEP = 3e-9


def edge_advance_function(
    load_at: Function,
    stiffness_at: Function,
    reference_length: float,
    corner_advance: float = 0.0,
    advance_limit: float = math.inf,
) -> Function:
    """The inverse d(P) of a rising contact law P(d), to round-off: advance d of the contact edge
    beyond the half-width without load, from the load. The function takes and returns arrays.

    Newton's method between the logarithms of both, started from a tabulated cubic through P and
    dP/dd.

    Parameters
    ----------
    load_at, stiffness_at
        P and dP/dd as functions of arrays d [length]
    reference_length
        a length of the profile; from 1e-22 to 1e15 of it, `advance_limit` at most, the cubic is
        tabulated, beyond this range P is a power of d
    corner_advance
        an advance at which P is less smooth
    advance_limit
        largest d

    Examples
    --------
    >>> float(edge_advance_function(lambda d: d**3, lambda d: 3 * d**2, 1.0)(np.array(8.0)))
    2.0
    """

    @cache
    def table() -> _LogTable:
        return _log_table(load_at, stiffness_at, reference_length, corner_advance, advance_limit)

    def edge_advance(loads: Array) -> Array:
        """Advance d [length] of the contact edge beyond the half-width without load, under each of
        the `loads` P, 0 where a load is not positive.

        The advance is solved for by Newton's method in the logarithms of load and advance, from a
        first guess by a table. Where a step leaves the bounds [least_advance, largest_advance],
        which close in, their geometric mean is taken instead.
        """
        positive_loads = np.where(loads > 0, loads, 1.0)
        advance, least_advance, largest_advance = table().first_guess(np.log(positive_loads))
        for _ in range(60):
            load_at_advance = load_at(advance)
            is_below = load_at_advance < positive_loads
            least_advance = np.where(is_below, advance, least_advance)
            largest_advance = np.where(is_below, largest_advance, advance)
            with np.errstate(divide="ignore", invalid="ignore"):
                log_step = (
                    np.log(positive_loads / load_at_advance)
                    * load_at_advance
                    / (advance * stiffness_at(advance))
                )
            newton_advance = advance * np.exp(np.clip(log_step, -1.0, 1.0))
            is_within_bounds = (newton_advance >= least_advance) & (
                newton_advance <= largest_advance
            )
            geometric_mean = np.sqrt(least_advance * largest_advance)
            advance = np.where(is_within_bounds, newton_advance, geometric_mean)
            # _CONVERGED_LOG_STEP: 3e-9
            has_converged = (np.abs(log_step) < _CONVERGED_LOG_STEP) | (
                largest_advance <= least_advance * (1 + 1e-15)
            )
            if np.all(has_converged):
                break
        return np.where(loads > 0, advance, 0.0)

    return edge_advance


class _LogTable(NamedTuple):
    """Table of the advance d(P) of the contact edge under a load P, n rows, ascending.

    Attributes
    ----------
    log_load, edge_advance
        (n,) ln P, and d [length]
    cubic
        cubic of ln d over ln P through the rows
    slope
        (n,) d ln d/d ln P of the cubic at the rows
    """

    log_load: Array
    edge_advance: Array
    cubic: scipy.interpolate.CubicHermiteSpline
    slope: Array

    def first_guess(self, log_load: Array) -> tuple[Array, Array, Array]:
        """First guess of the advance d(P) of the contact edge under loads P, given by their
        logarithm, and bounds of d from below and above; (n,) each [length].

        Inside the table the guess is a cubic of ln d over ln P, and the bounds are the d of the
        rows beside it. Beyond its ends d is a power of the load, by the slope of ln d over ln P in
        the first or last row; the bounds are half and twice the guess.
        """
        # ln P minus that of the first row or the last row of the table, 0 between them
        log_below_table = np.minimum(log_load - self.log_load[0], 0.0)
        log_above_table = np.maximum(log_load - self.log_load[-1], 0.0)
        log_advance_in_table = self.cubic(log_load - log_below_table - log_above_table)
        advance = np.exp(
            log_advance_in_table
            + self.slope[0] * log_below_table
            + self.slope[-1] * log_above_table
        )
        row_number_below = np.searchsorted(self.log_load[1:-1], log_load)
        is_in_table = log_below_table == log_above_table
        least_advance = np.where(is_in_table, self.edge_advance[row_number_below], advance / 2)
        largest_advance = np.where(
            is_in_table, self.edge_advance[row_number_below + 1], advance * 2
        )
        return advance, least_advance, largest_advance


def _log_table(
    load_at: Function,
    stiffness_at: Function,
    reference_length: float,
    corner_advance: float,
    advance_limit: float,
) -> _LogTable:
    """Table of the advance d(P) of the contact edge, the inverse of a rising contact law P(d): a
    cubic of ln d over ln P, which rises everywhere.

    d is how far the edge is beyond the half-width without load. Rows with a load that would
    overflow or vanish are left out, and the first ones, where loads are round-off. Below its first
    row the table goes on as a power of the load.

    Parameters
    ----------
    load_at, stiffness_at
        P and dP/dd as functions of d
    reference_length
        a length of the profile; the table covers 22 decades of d below and 15 above it [length]
    corner_advance
        a value of d at which the law is not smooth; it is a row of the table [length]
    advance_limit
        largest d that the profile allows [length]
    """
    first_advance = _LEAST_RATIO_TO_UNIT * reference_length
    last_advance = min(_LARGEST_RATIO_TO_UNIT * reference_length, advance_limit)
    # twenty rows to each factor e
    log_advances = np.arange(math.log(first_advance), math.log(last_advance), _LOG_STEP_OF_TABLE)
    advances = np.append(np.exp(log_advances), [corner_advance, advance_limit])
    advances = np.unique(advances[(advances > 0) & np.isfinite(advances)])
    with np.errstate(all="ignore"):
        loads = load_at(advances)
        # Rows with a load that neither vanishes nor overflows, and each load once.
        usable_row_numbers = np.flatnonzero((loads > 1e-290) & (loads < 1e290))
        log_loads, first_row_number_of_each_load = np.unique(
            np.log(loads[usable_row_numbers]), return_index=True
        )
        advances = advances[usable_row_numbers[first_row_number_of_each_load]]
        # Where the loads of neighbouring rows differ by round-off, d may fall as the load rises.
        first_rising_row_number = (
            int(np.max(np.flatnonzero(np.diff(advances) <= 0), initial=-1)) + 1
        )
        advances = advances[first_rising_row_number:]
        log_loads = log_loads[first_rising_row_number:]
        # slope of ln d over ln P, P/d over dP/dd, and that of the chord between neighbouring rows
        slopes = np.exp(log_loads) / (advances * stiffness_at(advances))
        chord_slopes = np.diff(np.log(advances)) / np.diff(log_loads)
    # As long as no slope is more than three times that of a chord beside it the cubic rises.
    least_chord_slopes = np.minimum(
        np.append(chord_slopes, np.inf), np.append(np.inf, chord_slopes)
    )
    slopes = np.fmin(slopes, 3 * least_chord_slopes)
    cubic = scipy.interpolate.CubicHermiteSpline(log_loads, np.log(advances), slopes)
    return _LogTable(log_loads, advances, cubic, slopes)


# --- power laws and their sums


def abel_load_factor(exponent: float) -> float:
    """The factor by which the Abel transform turns x^n into a load, n = `exponent`: int_0^(pi/2)
    sin(theta)^n d theta = (sqrt(pi)/2) Gamma((n+1)/2)/Gamma(n/2+1).

    >>> round(abel_load_factor(1.0), 15), round(abel_load_factor(2.0), 15)  # 1 and pi/4
    (1.0, 0.785398163397448)
    """
    numerator_argument = (exponent + 1) / 2
    denominator_argument = exponent / 2 + 1
    if exponent >= 300:  # each Gamma overflows, their quotient does not
        return (
            math.sqrt(math.pi)
            / 2
            * math.exp(math.lgamma(numerator_argument) - math.lgamma(denominator_argument))
        )
    return (
        math.sqrt(math.pi) / 2 * (math.gamma(numerator_argument) / math.gamma(denominator_argument))
    )


def law_of_power(modulus: float, exponent: float, length: float, rise: float) -> ContactLaw:
    """Contact law P(a) of the profile h = rise (|x|/length)^n, n = `exponent` >= 1 real: P = K
    (a/length)^n, K = E* n rise abel_load_factor(n), E* = `modulus`. `rise` is the height at |x| =
    `length`, a the contact half-width; `abel_load_factor(n)` is the integral of sin(theta)^n from 0
    to pi/2.

    >>> law = law_of_power(modulus=100.0, exponent=2.0, length=1.0, rise=0.5)  # Hertz with R = 1
    >>> round(float(law.edge_advance(np.array(25 * np.pi))), 12)
    1.0
    """
    load_at_length = modulus * exponent * rise * abel_load_factor(exponent)
    # the half-width without load is 0: the advance of the edge is a itself
    return ContactLaw(
        load=lambda a: load_at_length * np.power(a / length, exponent),
        edge_advance=lambda load: length * np.power(load / load_at_length, 1 / exponent),
        stiffness=lambda a: exponent * load_at_length / length * np.power(a / length, exponent - 1),
        exponent=exponent,
    )


def law_of_even_polynomial(modulus: float, length: float, rises: tuple[float, ...]) -> ContactLaw:
    """Contact law P(a) of the profile h = sum c_k (x/length)^(2 k), k from 1, c_k = `rises`
    [length]: P is the sum of the loads that each term alone would carry. `modulus` is E*, a the
    contact half-width; for a = length these loads are E* n c_k times the integral of sin(theta)^n
    from 0 to pi/2, n = 2 k.

    Raises
    ------
    InputError
        Where dP/da < 0 somewhere: the contact would split.

    Examples
    --------
    >>> law = law_of_even_polynomial(modulus=100.0, length=1.0, rises=(0.5,))  # Hertz with R = 1
    >>> round(float(law.edge_advance(np.array(25 * np.pi))), 12)
    1.0
    """
    k = np.arange(1.0, len(rises) + 1)
    # at a = length
    loads_of_terms = (
        modulus
        * 2
        * k
        * np.array(rises)
        * np.array([abel_load_factor(2 * half_exponent) for half_exponent in k])
    )
    # dP/da over a is a polynomial in a^2: (a/length)^2 at which it is negative, None where it never
    # is
    squared_ratio_at_fall = place_of_fall(loads_of_terms * k)
    if squared_ratio_at_fall is not None:
        half_width = length * float(np.sqrt(squared_ratio_at_fall))
        raise InputError(
            f"profile: the contact would split near a half-width of {half_width:.6g}; half-plane"
            " theory here needs one contact"
        )

    def load(a: Array) -> Array:
        squared_ratio = np.square(a / length)
        return np.asarray(squared_ratio * polynomial.polyval(squared_ratio, loads_of_terms))

    def stiffness(a: Array) -> Array:
        half_width_ratio = a / length
        return np.asarray(
            2
            * half_width_ratio
            / length
            * polynomial.polyval(half_width_ratio * half_width_ratio, loads_of_terms * k)
        )

    # The lowest term leads for small a: P goes as a^exponent there.
    index_of_lowest_term = int(np.flatnonzero(loads_of_terms > 0)[0])
    exponent = 2.0 * (index_of_lowest_term + 1)
    # With several terms dP/da may be small somewhere, so that a(P) is steep.
    has_several_terms = sum(rise != 0 for rise in rises) > 1
    # d of the law is a itself: the half-width without load is 0.
    return ContactLaw(
        load,
        edge_advance_function(load, stiffness, length),
        stiffness,
        exponent=exponent,
        half_width_may_be_steep=has_several_terms,
    )


# --- flat and rounded


# Below this tau the closed form of F cancels.
_SMALL_TAU = 0.3
_SERIES_NUMBERS = np.arange(1.0, 17.0)
_SERIES_OF_LOAD_FUNCTION = -((-1.0) ** _SERIES_NUMBERS) * 2 / (4 * _SERIES_NUMBERS**2 - 1)


def flat_and_rounded_load_function(tau: ArrayLike) -> Array:
    """F(tau) = (1 + tau^2) arctan(tau) - tau to full relative accuracy: the load of a flat face of
    half-length b with rounded ends of radius R, tau = sqrt(a^2 - b^2)/b, divided by E* b^2/(2 R).

    a is the contact half-width, E* the composite modulus. For tau below 0.3, where the closed form
    loses digits, by the series 2 tau^3/3 - 2 tau^5/15 + ...

    >>> round(float(flat_and_rounded_load_function(1.0)), 12)  # pi/2 - 1
    0.570796326795
    """
    taus = np.asarray(tau, dtype=float)
    closed_form = (1 + taus * taus) * np.arctan(taus) - taus
    is_small = taus < _SMALL_TAU
    if not np.any(is_small):
        return closed_form
    small_tau = np.minimum(taus, _SMALL_TAU)
    squared_tau = small_tau * small_tau
    # Horner's rule, from the last of sixteen coefficients
    series_value = np.full(np.shape(taus), _SERIES_OF_LOAD_FUNCTION[-1])
    for coefficient in _SERIES_OF_LOAD_FUNCTION[-2::-1].tolist():
        series_value = series_value * squared_tau + coefficient
    return np.where(is_small, series_value * small_tau * squared_tau, closed_form)


def law_of_flat_and_rounded(modulus: float, radius: float, flat_half_length: float) -> ContactLaw:
    """Contact law P(a) of a flat face of half-length b with parabolic ends of radius R
    (Ciavarella, Hills and Monno 1998). `modulus` is E*, a the contact half-width, R = `radius`,
    b = `flat_half_length`.

        P = (E* b^2/(2 R)) F(tau),  dP/da = (E*/R) a arctan(tau),  tau = sqrt(a^2 - b^2)/b

    F(tau) = (1 + tau^2) arctan(tau) - tau is `flat_and_rounded_load_function`; the functions of the
    law take the advance d = a - b of the edge of contact; tau is tan(angle) where that paper has
    cos(angle) = b/a.

    >>> law = law_of_flat_and_rounded(modulus=2.0, radius=1.0, flat_half_length=1.0)
    >>> round(float(law.load(np.sqrt(2.0) - 1)), 12)  # tau = 1
    0.570796326795
    """
    b = flat_half_length
    load_unit = modulus * b**2 / (2 * radius)

    def tau(d: Array) -> Array:
        """sqrt(a^2 - b^2)/b, without cancellation."""
        return np.sqrt(d / b * (2 + d / b))

    def load(d: Array) -> Array:
        """P at advances d."""
        return load_unit * flat_and_rounded_load_function(tau(d))

    def stiffness(d: Array) -> Array:
        """dP/da at advances d."""
        return modulus / radius * (b + d) * np.arctan(tau(d))

    return ContactLaw(
        load, edge_advance_function(load, stiffness, b), stiffness, least_half_width=b
    )


# --- two curvatures


def law_of_two_curvatures(
    modulus: float, inner_radius: float, outer_radius: float, inner_half_length: float
) -> ContactLaw:
    """Contact law P(a) of a profile with h'' = 1/R1 up to x = b = `inner_half_length` and 1/R2
    beyond, R1 = `inner_radius`, R2 = `outer_radius`; R2 infinite makes a wedge with a rounded tip.
    `modulus` is E*, a the contact half-width.

    Hertz up to a = b, then with t = sqrt(a^2 - b^2) and `flat_and_rounded_load_function`
    F(tau) = (1 + tau^2) arctan(tau) - tau

        P = (E*/(2 R1)) [b t + a^2 arcsin(b/a)] + (E* b^2/(2 R2)) F(t/b),
        dP/da = E* a [arcsin(b/a)/R1 + arccos(b/a)/R2]

    Both terms grow: all digits are kept from R2/R1 = 0 to infinity.

    >>> law = law_of_two_curvatures(
    ...     modulus=100.0, inner_radius=1.0, outer_radius=1.0, inner_half_length=0.3
    ... )
    >>> round(float(law.edge_advance(np.array(25 * np.pi))), 12)  # Hertz
    1.0
    """
    b = inner_half_length
    scaled_inner_curvature = modulus / inner_radius  # E* h'' inside of b
    scaled_outer_curvature = modulus / outer_radius  # E* h'' beyond
    load_unit = scaled_outer_curvature * b * b / 2

    # Up to a = b the contact is inside of b: with a in place of b, t = 0, it is Hertz.
    def load(a: Array) -> Array:
        """P at half-widths a."""
        inner_end = np.minimum(a, b)
        t = np.sqrt((a - inner_end) * (a + inner_end))
        inner_load = scaled_inner_curvature / 2 * (inner_end * t + a * a * np.arctan2(inner_end, t))
        return inner_load + load_unit * flat_and_rounded_load_function(t / b)

    def stiffness(a: Array) -> Array:
        """dP/da at half-widths a; arcsin(b/a) and arccos(b/a) as arctan of b/t and t/b."""
        inner_end = np.minimum(a, b)
        t = np.sqrt((a - inner_end) * (a + inner_end))
        return a * (
            scaled_inner_curvature * np.arctan2(inner_end, t)
            + scaled_outer_curvature * np.arctan2(t, inner_end)
        )

    return ContactLaw(
        load,
        edge_advance_function(load, stiffness, b, corner_advance=b),
        stiffness,
        corner_half_widths=(b,),
    )


# --- tables of heights

# Intervals in a group at most, when the sums over near knots are taken knot by knot.
_MOST_INTERVALS_OF_GROUP = 32


@dataclass(frozen=True, eq=False)
class _TableSeries:
    """P and dP/da of a table of heights as Chebyshev series on n intervals of u = sqrt(a - knot),
    one series each.

    Attributes
    ----------
    knots
        (n,) the knot of the profile behind which the interval lies [length]
    begin_u, end_u
        (n,) values of u at both ends of the interval
    begin_half_widths
        (n,) half-width a at which the interval begins, ascending [length]
    load, stiffness
        the series of P and of dP/da
    """

    knots: Array
    begin_u: Array
    end_u: Array
    begin_half_widths: Array
    load: SeriesAsPowers
    stiffness: SeriesAsPowers

    def load_or_stiffness_at(
        self, interval_number: Indices, u: Array, load_or_stiffness: SeriesAsPowers
    ) -> Array:
        """P or dP/da, that of the given series, at u on the intervals with these numbers.
        `begin_u` and `end_u` (n,) are their ends in u = sqrt(a - knot), a the contact
        half-width; a knot is a half-width at which the curvature of the profile jumps.
        """
        begin_u = self.begin_u[interval_number]
        end_u = self.end_u[interval_number]
        place_in_interval = (2 * u - begin_u - end_u) / (end_u - begin_u)
        return load_or_stiffness(interval_number, np.minimum(place_in_interval, 1.0))

    def sample_half_widths(self) -> Array:
        """Half-widths at the nodes and both ends of every interval, (n, nodes) [length], at which
        dP/da is tested: where it falls behind a knot it is least at the next one. An interval is a
        range of u = sqrt(a - knot) from `begin_u` to `end_u`, a the contact half-width; a
        knot is a half-width at which the curvature of the profile jumps. CHEBYSHEV_NODES are those
        of [-1, 1].
        """
        nodes_and_ends = np.concatenate([[-1.0], CHEBYSHEV_NODES, [1.0]])
        range_of_u = (self.end_u - self.begin_u)[:, None]
        u = self.begin_u[:, None] + range_of_u * (1 + nodes_and_ends) / 2
        return np.asarray(self.knots[:, None] + np.square(u))


def law_of_table(modulus: float, profile: Tabulated) -> ContactLaw:
    """Contact law P(a) of a profile given by a table of heights h(x): its curvature kappa is
    constant between knots b_j, so that P is a sum over flat punches with rounded ends.

    `modulus` is E*, a the contact half-width, kappa_j the curvature behind b_j. The functions of
    the law take the advance of a beyond the half-width without load.

        dP/da = E* a [kappa_0 pi/2 + sum over b_j < a of (kappa_j - kappa_(j-1)) arccos(b_j/a)]

    The sums (the Abel transform of the table) are taken once, at the nodes of Chebyshev series in
    sqrt(a - b_j) behind each knot; up to the second knot all is in closed form.

    Raises
    ------
    InputError
        For rows under which the contact would split, with the row and what to do.
    ProfileDataError
        Later, by the returned law, for a load that needs a wider table.

    Examples
    --------
    >>> rows = [(0.1 * k, (0.1 * k) ** 2 / 2) for k in range(11)]  # Hertz with R = 1
    >>> round(
    ...     float(law_of_table(100.0, Tabulated(points=rows)).load(np.array(0.6))) / np.pi, 9
    ... )  # 25 a^2
    9.0
    """
    # x of the rows, x >= 0, and the curvature behind each
    spline = profile.spline()
    # Where the table begins with a flat, its end is the first knot, and the half-width without
    # load.
    first_knot_number = int(np.flatnonzero(spline.curvature > 0)[0])
    knots = spline.x[first_knot_number:]
    scaled_curvatures = modulus * spline.curvature[first_knot_number:]  # E* kappa behind each knot
    least_half_width = float(knots[0])
    extent = float(knots[-1])
    # Up to the second knot it is Hertz, or flat and rounded, with E*/R the first of these scaled
    # curvatures.
    law_to_second_knot = (
        law_of_flat_and_rounded(scaled_curvatures[0], 1.0, least_half_width)
        if least_half_width > 0
        else law_of_power(scaled_curvatures[0], 2.0, 1.0, 0.5)
    )

    # P and dP/da as functions of the advance d of the edge beyond the half-width without load
    table_law = _TableLaw(
        law_to_second_knot, _series_of_table(knots, scaled_curvatures), least_half_width
    )
    largest_load = float(table_law.load(np.array(extent - least_half_width)))
    # the inverse, d as a function of P
    advance_under_load = law_to_second_knot.edge_advance
    if table_law.has_series:  # more than two knots
        advance_under_load = edge_advance_function(
            table_law.load,
            table_law.stiffness,
            extent,
            corner_advance=float(knots[1]) - least_half_width,
            advance_limit=extent - least_half_width,
        )

    def edge_advance(loads: Array) -> Array:
        """Advance d under loads P; ProfileDataError where the contact would be wider than the
        table.
        """
        needed_load = float(np.max(loads, initial=0.0))
        if needed_load > largest_load:
            raise ProfileDataError(
                f"profile: the normal load {needed_load:.6g} needs a contact wider than the table,"
                f" whose last x = {extent:.6g} carries {largest_load:.6g}"
            )
        return np.asarray(advance_under_load(loads))

    if table_law.has_series:
        table_law.require_no_split(profile)
    # dP/da is not smooth at the inner knots
    corner_half_widths = tuple(knots[1:-1].tolist())
    return ContactLaw(
        table_law.load,
        edge_advance,
        table_law.stiffness,
        least_half_width,
        corner_half_widths,
        extent=extent,
    )


class _TableLaw(NamedTuple):
    """P and dP/da of a profile given by a table of heights: in closed form up to its second knot,
    by Chebyshev series behind it.

    Attributes
    ----------
    law_to_second_knot
        law of the contact up to the second knot, Hertz or flat and rounded
    table_series
        Chebyshev series of P and dP/da behind every knot from the second on
    least_half_width
        contact half-width without load [length]
    """

    law_to_second_knot: ContactLaw
    table_series: _TableSeries
    least_half_width: float

    @property
    def has_series(self) -> bool:
        """Whether the table has more than two knots."""
        return len(self.table_series.knots) > 0

    def require_no_split(self, profile: Tabulated) -> None:
        """Refuse a table under which the contact would split, dP/da < 0: InputError with the row of
        the `profile` and what to do. It needs more than two knots.
        """
        # where dP/da may be least
        half_widths = self.table_series.sample_half_widths()
        stiffness = self.stiffness(half_widths - self.least_half_width)
        # Round-off may leave that much below 0 where the profile is straight.
        is_negative = stiffness < -1e-12 * np.max(stiffness)
        if np.any(is_negative):
            raise _contact_splits_error(profile, float(np.min(half_widths[is_negative])))

    def load(self, d: Array) -> Array:
        """P at advances d of the edge [force per thickness]."""
        return self._load_or_stiffness(d, self.table_series.load, self.law_to_second_knot.load)

    def stiffness(self, d: Array) -> Array:
        """dP/da at advances d of the edge [stress]."""
        return self._load_or_stiffness(
            d, self.table_series.stiffness, self.law_to_second_knot.stiffness
        )

    def _load_or_stiffness(
        self,
        d: Array,
        series_behind_knot: SeriesAsPowers,
        closed_form_before_knot: Callable[[Array], Array],
    ) -> Array:
        """P or dP/da at advances d of the edge of contact beyond `least_half_width`, the half-width
        without load: in closed form up to the second knot, by Chebyshev series behind it.

        A knot is a half-width at which the curvature of the profile jumps. The range behind each
        knot is divided into intervals, each with its own series in u = sqrt(a - knot), a the
        half-width.

        Parameters
        ----------
        series_behind_knot
            the series of P or of dP/da; there are none without a third knot
        closed_form_before_knot
            P or dP/da as a function of d, for half-widths before the second knot
        """
        table_series = self.table_series
        if not self.has_series:
            return closed_form_before_knot(d)
        half_widths = d + self.least_half_width
        # number of the interval of each half-width, -1 before the second knot
        interval_number = (
            np.searchsorted(table_series.begin_half_widths, half_widths, side="right") - 1
        )
        distance_from_knot = np.maximum(half_widths - table_series.knots[interval_number], 0.0)
        load_or_stiffness = table_series.load_or_stiffness_at(
            np.maximum(interval_number, 0), np.sqrt(distance_from_knot), series_behind_knot
        )
        is_before_second_knot = interval_number < 0
        if np.any(is_before_second_knot):
            # of d itself, which keeps its digits beside a flat
            load_or_stiffness[is_before_second_knot] = closed_form_before_knot(
                d[is_before_second_knot]
            )
        return load_or_stiffness


class _IntervalOfU(NamedTuple):
    """An interval [begin_u, end_u] of u = sqrt(a - knot), behind a `knot` of a table of heights; a
    is the contact half-width.
    """

    knot: float
    begin_u: float
    end_u: float


class _IntervalGroup(NamedTuple):
    """Successive intervals of half-widths a, and what the far knots of the table below all of them
    add to P and dP/da there, as one Chebyshev series.

    Attributes
    ----------
    first_interval_number, end_interval_number
        number of the first interval of the group, and of the first behind it
    n_far_knots
        number of knots, from the first on, whose sums the series hold
    half_width_range
        least and largest a on which the series hold [length]
    far_series
        (nodes, 2) series in a of the sums over the far knots, of P and of dP/da/a
    """

    first_interval_number: int
    end_interval_number: int
    n_far_knots: int
    half_width_range: tuple[float, float]
    far_series: Array

    def far_sums_at(self, half_widths: Array) -> Array:
        """Sums of P and of dP/da/a over the far knots at half-widths (...) within the range of the
        series, (..., 2).
        """
        least_half_width, largest_half_width = self.half_width_range
        range_length = largest_half_width - least_half_width
        place_in_range = (half_widths - least_half_width) * 2 / range_length - 1
        far_sums = np.asarray(chebyshev.chebval(place_in_range, self.far_series), dtype=float)
        return np.moveaxis(far_sums, 0, -1)


def _intervals_of_u(knots: Array) -> list[_IntervalOfU]:
    """Intervals of u = sqrt(a - knot), a the contact half-width, behind every knot of a table from
    the second on. On each of them one Chebyshev series can serve for P(a).

    P is smooth in u. But the knot before leaves a singularity below, at u^2 = -(its distance). So a
    first interval as long as the square root of that distance is followed by intervals that double
    u. `knots` (k,) are half-widths at which the curvature of the profile jumps.
    """
    intervals: list[_IntervalOfU] = []
    for knot_before, knot, next_knot in zip(
        knots[:-2].tolist(), knots[1:-1].tolist(), knots[2:].tolist(), strict=True
    ):
        u_at_next_knot = (next_knot - knot) ** 0.5
        first_interval_length = (knot - knot_before) ** 0.5
        doublings = range(math.ceil(math.log2(u_at_next_knot / first_interval_length)))
        interval_ends = [0.0, *(first_interval_length * 2.0**k for k in doublings), u_at_next_knot]
        # A last interval that would be a small part of the one before is joined to it.
        if len(interval_ends) > 2 and u_at_next_knot - interval_ends[-2] < 0.1 * (
            interval_ends[-2] - interval_ends[-3]
        ):
            del interval_ends[-2]
        intervals += [
            _IntervalOfU(knot, begin_u, end_u) for begin_u, end_u in pairwise(interval_ends)
        ]
    return intervals


class _KnotSums(NamedTuple):
    """P and dP/da of a table as sums over its knots, each a flat punch with rounded ends.

    Attributes
    ----------
    knots
        (k,) half-widths at which the curvature h'' of the profile jumps, ascending
    jumps
        (k,) jumps of E* h'' there
    """

    knots: Array
    jumps: Array

    def sums_over_knots(
        self, half_width: Array, origin: Array, distance: Array, knot_numbers: slice
    ) -> Array:
        """Sums of P and of dP/da/a over some knots at contact half-widths a; the last axis holds
        the two.

            P = (1/2) sum over b < a of jump (a^2 arccos(b/a) - b sqrt(a^2 - b^2)),
            dP/da = a sum of jump arccos(b/a)

        b are the knots, half-widths at which the curvature h'' of the profile jumps; jump is that
        of E* h''. E* is the composite modulus.

        Parameters
        ----------
        half_width
            (..., 1) a [length]
        origin, distance
            (..., 1) a = origin + distance, so that a - b is known without cancellation [length]
        knot_numbers
            which knots are summed over
        """
        b = self.knots[knot_numbers]
        jumps = self.jumps[knot_numbers]
        distance_from_knots = np.maximum((origin - b) + distance, 0.0)
        # sqrt(a^2 - b^2)
        sqrt_of_square_difference = np.sqrt(distance_from_knots * (half_width + b))
        arccos_of_ratio = np.where(
            distance_from_knots > 0, np.arctan2(sqrt_of_square_difference, b), 0.0
        )
        twice_load_per_jump = np.where(
            distance_from_knots > 0,
            half_width * half_width * arccos_of_ratio - b * sqrt_of_square_difference,
            0.0,
        )
        load = twice_load_per_jump @ jumps / 2
        stiffness_over_width = arccos_of_ratio @ jumps
        return np.stack([load, stiffness_over_width], axis=-1)

    def with_far_knots(
        self, wider_group: _IntervalGroup, half_width_range: tuple[float, float]
    ) -> _IntervalGroup:
        """A group of intervals with the series over all its far knots, from the series of the wider
        group that it was a half of, over fewer knots.

        A knot is a half-width at which the curvature of the profile jumps. It is far if it is
        farther below the least half-width of the group than the range of half-widths is long. Sums
        over far knots are smooth on the range, and one Chebyshev series holds them.

        Parameters
        ----------
        wider_group
            the intervals of the group, still with the series of the wider group: sums of P and of
            dP/da/a (`far_series`) over its first `n_far_knots` knots, on its wider range
        half_width_range
            least and largest half-width of the group itself [length]
        """
        least_half_width, largest_half_width = half_width_range
        half_widths = (
            least_half_width + (largest_half_width - least_half_width) * (1 + CHEBYSHEV_NODES) / 2
        )
        # knots below the least half-width by more than the length of the range
        n_knots_far_below = int(
            np.searchsorted(self.knots, 2 * least_half_width - largest_half_width)
        )
        n_far_knots = max(n_knots_far_below, wider_group.n_far_knots)
        least_half_width_of_wider_range, largest_half_width_of_wider_range = (
            wider_group.half_width_range
        )
        place_in_wider_range = (half_widths - least_half_width_of_wider_range) * (
            2 / (largest_half_width_of_wider_range - least_half_width_of_wider_range)
        ) - 1
        # P and dP/da/a of the far knots of the wider group, at the nodes, (nodes, 2)
        far_sums = chebyshev.chebval(place_in_wider_range, wider_group.far_series).T
        half_width_column = half_widths[:, None]
        # and of the knots that are far from this group alone
        far_sums = far_sums + self.sums_over_knots(
            half_width_column,
            half_width_column,
            np.zeros((1, 1)),
            slice(wider_group.n_far_knots, n_far_knots),
        )
        return wider_group._replace(
            n_far_knots=n_far_knots,
            half_width_range=half_width_range,
            far_series=chebyshev_coefficients(far_sums.T).T,
        )


def _series_of_table(knots: Array, scaled_curvatures: Array) -> _TableSeries:
    """Chebyshev series of P(a) and dP/da behind every knot b of a table of heights, from the second
    knot on, a the contact half-width; none where there are no more than two knots.

    P is smooth in u = sqrt(a - b). The range behind a knot is divided into intervals of u, each
    with its own series.

    Parameters
    ----------
    knots
        (k,) half-widths at which the curvature h'' of the profile jumps, ascending
    scaled_curvatures
        (k,) E* h'' behind each knot [stress/length]
    """
    intervals = _intervals_of_u(knots)
    knot_of_interval = np.array([interval.knot for interval in intervals])
    begin_u = np.array([interval.begin_u for interval in intervals])
    end_u = np.array([interval.end_u for interval in intervals])
    # Chebyshev nodes and both ends of every interval, as values of u and of a - b
    nodes_and_ends = np.concatenate([[-1.0], CHEBYSHEV_NODES, [1.0]])
    u_at_nodes = begin_u[:, None] + (end_u - begin_u)[:, None] * (1 + nodes_and_ends) / 2
    distances_from_knot = np.square(u_at_nodes)
    # P and dP/da/a as sums over the knots, (intervals, nodes and ends) each
    knot_sums = _KnotSums(knots, np.diff(scaled_curvatures, prepend=0.0))
    load, stiffness_over_width = np.moveaxis(
        _sums_over_all_knots(knot_sums, knot_of_interval, distances_from_knot), -1, 0
    )
    stiffness = stiffness_over_width * (knot_of_interval[:, None] + distances_from_knot)
    # The series are through the nodes alone.
    return _TableSeries(
        knot_of_interval,
        begin_u,
        end_u,
        begin_half_widths=knot_of_interval + begin_u * begin_u,
        load=SeriesAsPowers(chebyshev_coefficients(load[:, 1:-1]).T),
        stiffness=SeriesAsPowers(chebyshev_coefficients(stiffness[:, 1:-1]).T),
    )


def _sums_over_all_knots(knot_sums: _KnotSums, knot_of_interval: Array, distances: Array) -> Array:
    """P and dP/da/a of a profile given by a table of heights, as sums over all knots below a, at
    half-widths a in n intervals that ascend; (n, j, 2) at j half-widths of each interval.

    A knot is a half-width at which the curvature of the profile jumps. Sums over the far knots of a
    range of half-widths, farther below it than it is long, are smooth: one Chebyshev series serves
    for the range. Ranges are halved, and each half adds the knots that are now far. So the time
    grows about as m log m with the number m of knots, not as its square. Over the near knots of the
    last, short ranges the sums are taken one by one.

    Parameters
    ----------
    knot_sums
        sums over any of the knots
    knot_of_interval
        (n,) knot from which the half-widths of each interval are counted, ascending [length]
    distances
        (n, j) of the half-widths from the knot of their interval, ascending [length]
    """
    half_widths = knot_of_interval[:, None] + distances
    sums_at_half_widths = np.zeros((*half_widths.shape, 2))
    # A group is a row of neighbouring intervals, with the series of its far knots.
    groups: list[_IntervalGroup] = []
    if len(knot_of_interval):
        groups.append(
            _IntervalGroup(
                first_interval_number=0,
                end_interval_number=len(knot_of_interval),
                n_far_knots=0,
                half_width_range=(0.0, 1.0),  # any range: a series of zeros holds on all
                far_series=np.zeros((len(CHEBYSHEV_NODES), 2)),
            )
        )
    while groups:
        group = groups.pop()
        half_width_range = (
            half_widths[group.first_interval_number, 0],
            half_widths[group.end_interval_number - 1, -1],
        )
        # It still has the series of the wider group of which it was a half.
        group = knot_sums.with_far_knots(group, half_width_range)
        # _MOST_INTERVALS_OF_GROUP: 32
        if group.end_interval_number - group.first_interval_number > _MOST_INTERVALS_OF_GROUP:
            middle_interval_number = (group.first_interval_number + group.end_interval_number) // 2
            groups.append(group._replace(end_interval_number=middle_interval_number))
            groups.append(group._replace(first_interval_number=middle_interval_number))
            continue
        interval_slice = slice(group.first_interval_number, group.end_interval_number)
        far_sums = group.far_sums_at(half_widths[interval_slice])
        largest_half_width = half_width_range[1]
        n_knots_reached = int(np.searchsorted(knot_sums.knots[:-1], largest_half_width))
        near_sums = knot_sums.sums_over_knots(
            half_widths[interval_slice, :, None],
            knot_of_interval[interval_slice, None, None],
            distances[interval_slice, :, None],
            slice(group.n_far_knots, n_knots_reached),
        )
        sums_at_half_widths[interval_slice] = far_sums
        sums_at_half_widths[interval_slice] += near_sums
    return sums_at_half_widths


def _contact_splits_error(profile: Tabulated, half_width: float) -> InputError:
    """The error for a table of heights under which the contact would split near a `half_width`; its
    message has the row of the table, the cause and what to do.

    Heights that are rounded to few digits rise by equal steps: with those no engine can do
    anything, and the error is a ProfileDataError.
    """
    row_number = profile.row_before(half_width)
    # step in which h is written, None where it has digits enough
    height_step = profile.step_of_heights()
    x, h = profile.points.values[row_number].tolist()
    cause = "the curve through the rows bends down there"
    advice = "smooth the rows until it does not"
    if height_step is not None:
        cause = (
            f"h is written in steps of {height_step:.6g}, and the curve through such rows goes up"
            " by stairs"
        )
        advice = (
            "write h with more digits, leave rows out until each rises by many steps, or give a"
            " formula that fits them"
        )
    # `place_in_input`: the words that name the row for the user
    place = f"{profile.place_in_input(row_number)}, x = {x:.6g} and h = {h:.6g}"
    message = (
        f"{place}: the contact would split near a half-width of {half_width:.6g}: {cause}; {advice}"
    )
    return InputError(message) if height_step is None else ProfileDataError(message)


# --- Python functions


# Octaves of a half-width that have series; below them P is a power of a.
_OCTAVE_COUNT = 54
# Relative errors of P and of dP/da to which their series are resolved, where no height is rounded.
_NEGLIGIBLE_LOAD_SHARE = 4e-15
_NEGLIGIBLE_STIFFNESS_SHARE = 1e-12


@dataclass(frozen=True, eq=False)
class _SeriesBehindCorner:
    """P and dP/da as piecewise Chebyshev series in u, for half-widths a from one corner of the
    profile, at `begin_half_width`, to the next.

    From the middle on u = a - begin_half_width. Behind a corner of the profile, and beside a flat,
    P is smooth in the square root only: there u = sqrt(a - begin_half_width).

    Attributes
    ----------
    begin_half_width
        half-width at the corner [length]
    is_in_square_root
        whether u is the square root of the distance from the corner
    load, stiffness
        series of P and of dP/da in u
    """

    begin_half_width: float
    is_in_square_root: bool
    load: PiecewiseSeries
    stiffness: PiecewiseSeries

    @property
    def exponent_of_load(self) -> float:
        """Exponent n of P ~ u^n below the least u that has a series, (u/P) dP/du there."""
        first_u = np.array(self.load.interval_ends[0])
        width_per_u = 2 * first_u if self.is_in_square_root else 1.0  # da/du
        return float(first_u * self.stiffness(first_u) / self.load(first_u) * width_per_u)

    def load_or_stiffness_at(self, u: Array, derivative_order: int) -> Array:
        """P (`derivative_order` 0) or dP/da (1) at u, a the contact half-width; below the least u
        that has a series as a power of u. u is the distance of the half-width from the corner or,
        if `is_in_square_root`, its square root.
        """
        # the piecewise Chebyshev series, from `interval_ends[0]` on
        piecewise_series = (self.load, self.stiffness)[derivative_order]
        first_u = float(piecewise_series.interval_ends[0])
        values_of_series = piecewise_series(np.maximum(u, first_u))
        if first_u == 0:
            return values_of_series
        # P goes as u^`exponent_of_load` there. For dP/da of a sharp wedge the exponent is 0, to
        # round-off.
        exponent = max(
            self.exponent_of_load - derivative_order * (2 if self.is_in_square_root else 1), 0.0
        )
        return values_of_series * np.minimum(u / first_u, 1.0) ** exponent


def law_of_function(modulus: float, profile: CallableProfile) -> ContactLaw:
    """Contact law P(a) of a profile whose slope h'(x) is a Python function: P and dP/da by
    quadrature, stored as piecewise Chebyshev series. `modulus` is E*, a the contact half-width; h
    is defined up to x = `extent`.

    Raises
    ------
    InputError
        For a profile under which the contact would split.
    ProfileDataError
        Later, by the returned law, for a load that needs a wider contact than `extent`.

    Examples
    --------
    >>> law = law_of_function(
    ...     100.0, CallableProfile(slope_function=lambda x: x, extent=2.0)
    ... )  # Hertz with R = 1
    >>> round(float(law.edge_advance(np.array(25 * np.pi))), 12)
    1.0
    """
    # distances from the middle at which h'' jumps, ascending
    jump_distances = _corners(profile)
    # the half-length of a flat, 0 without one: it is the half-width without load
    least_half_width = _flat_half_length(profile, jump_distances)
    corners_beyond_flat = [
        corner for corner in jump_distances if least_half_width < corner < profile.extent
    ]
    # P and dP/da are smooth between two of these half-widths
    first_half_widths = [least_half_width, *corners_beyond_flat]
    half_width_ranges = list(pairwise([*first_half_widths, profile.extent]))
    descending_corners = tuple(
        reversed(first_half_widths if least_half_width else corners_beyond_flat)
    )
    series_of_ranges = [
        _series_behind_corner(
            modulus, profile, first_half_width, last_half_width, descending_corners
        )
        for first_half_width, last_half_width in half_width_ranges
    ]
    last_load_series = series_of_ranges[-1].load
    largest_load = float(last_load_series(last_load_series.interval_ends[-1]))

    # P and dP/da as functions of the advance d of the edge beyond the half-width without load, and
    # d as a function of the load
    load_or_stiffness = partial(_load_or_stiffness, series_of_ranges, least_half_width)
    load_at = partial(load_or_stiffness, derivative_order=0)
    stiffness_at = partial(load_or_stiffness, derivative_order=1)
    advance_under_load = edge_advance_function(
        load_at, stiffness_at, profile.extent, advance_limit=profile.extent - least_half_width
    )

    def edge_advance(loads: Array) -> Array:
        """Advance d under loads P; ProfileDataError where the contact would be wider than the
        extent of the profile.
        """
        needed_load = float(np.max(loads, initial=0.0))
        if needed_load > largest_load * (1 + 1e-12):
            raise ProfileDataError(
                f"profile.extent = {profile.extent:.6g}: the normal load {needed_load:.6g} needs a"
                f" wider contact, the extent carries {largest_load:.6g}"
            )
        return advance_under_load(loads)

    _require_no_split(stiffness_at, least_half_width, half_width_ranges)
    return ContactLaw(
        load=load_at,
        edge_advance=edge_advance,
        stiffness=stiffness_at,
        least_half_width=least_half_width,
        corner_half_widths=tuple(corners_beyond_flat),
        exponent=series_of_ranges[0].exponent_of_load if not least_half_width else 2.0,
        extent=profile.extent,
        half_width_may_be_steep=True,
        # dP/da takes one derivative of a given h', two of a given h: it is rounded most.
        relative_roundoff=max(1e-11, profile.relative_load_errors.stiffness),
    )


def _require_no_split(
    stiffness_at: Function, least_half_width: float, half_width_ranges: list[tuple[float, float]]
) -> None:
    """Refuse a profile under which the contact would split: InputError with the least half-width at
    which dP/da < 0, by more than round-off.

    `stiffness_at` is dP/da as a function of the advance of a beyond `least_half_width`, the
    half-width without load. It is sampled at 200 half-widths of each of the ranges between two
    corners of the profile.
    """
    half_widths = np.unique(
        np.concatenate(
            [
                np.linspace(first_half_width, last_half_width, 200)
                for first_half_width, last_half_width in half_width_ranges
            ]
        )
    )
    stiffness_at_samples = stiffness_at(half_widths - least_half_width)
    is_negative = stiffness_at_samples < -1e-10 * np.max(stiffness_at_samples)
    if np.any(is_negative):
        raise InputError(
            "profile: the contact would split near a half-width of"
            f" {half_widths[is_negative][0]:.6g}"
        )


def _load_or_stiffness(
    series_of_ranges: list[_SeriesBehindCorner],
    least_half_width: float,
    d: Array,
    derivative_order: int,
) -> Array:
    """P (`derivative_order` 0) or dP/da (1) of a contact whose edge is d beyond the half-width
    without load, `least_half_width`; an array like d.

    `series_of_ranges` has series of both for each range of half-widths between two corners of the
    profile, ascending. They are series in u: the distance of the half-width from the start of its
    range or, if `is_in_square_root`, the square root of that distance.
    """
    half_width = least_half_width + d
    load_or_stiffness = np.zeros(d.shape)
    first_half_widths = [range_series.begin_half_width for range_series in series_of_ranges]
    range_number_of_half_width = np.maximum(
        np.searchsorted(first_half_widths, half_width, side="right") - 1, 0
    )
    for range_number, range_series in enumerate(series_of_ranges):
        is_in_range = range_number_of_half_width == range_number
        if np.any(is_in_range):
            # d itself has more digits beside a flat.
            distances = d if range_number == 0 else half_width - range_series.begin_half_width
            distance_in_range = distances[is_in_range]
            u = np.sqrt(distance_in_range) if range_series.is_in_square_root else distance_in_range
            load_or_stiffness[is_in_range] = range_series.load_or_stiffness_at(u, derivative_order)
    return load_or_stiffness


def _series_behind_corner(
    modulus: float,
    profile: CallableProfile,
    first_half_width: float,
    last_half_width: float,
    corners: tuple[float, ...],
) -> _SeriesBehindCorner:
    """Chebyshev series of P and dP/da for contact half-widths a between two corners of a profile,
    by quadrature of its slope.

    The series run in u = a - first_half_width, or in its square root behind a corner, where P is
    smooth in the square root only. The range of u is first cut into octaves, 54 at most. These are
    halved until the series are resolved.

    Parameters
    ----------
    modulus
        E* [stress]
    first_half_width, last_half_width
        half-widths at the two corners; 0 at the middle of the profile [length]
    corners
        places where the slope has corners, descending [length]

    Raises
    ------
    InputError
        Where the function of the profile is too rough.
    """
    is_in_square_root = first_half_width > 0
    range_length = last_half_width - first_half_width
    largest_u = np.sqrt(range_length) if is_in_square_root else range_length
    # octaves: each end is twice the one before
    interval_ends = largest_u * 0.5 ** np.arange(_OCTAVE_COUNT - 1, -1.0, -1.0)
    if is_in_square_root and profile.slope(np.array(first_half_width)) > 0:
        # P and dP/da are positive at a corner inside the contact: a few octaves resolve them.
        interval_ends = np.concatenate([[0.0], interval_ends[-4:]])
    elif is_in_square_root:
        interval_ends = interval_ends[interval_ends > 1e-5 * np.sqrt(first_half_width)]

    def load_or_stiffness(u: Array, derivative_order: int) -> Array:
        """P (`derivative_order` 0) or dP/da (1) by quadrature."""
        distance = u**2 if is_in_square_root else u
        return _abel_integral(
            modulus, profile, first_half_width, distance, corners, derivative_order
        )

    # u at which P and dP/da give the size of negligible errors. Beside a flat, or behind a corner,
    # the slope is known to round-off of its largest value, and its derivative jumps within
    # round-off of the corner: there it is the end of the range. From the middle on it is the end of
    # each octave.
    u_of_reference_values = interval_ends[-1:] if is_in_square_root else interval_ends[1:]
    # Errors that are negligible, of P (4e-15 of it) and of dP/da (1e-12). Those that the round-off
    # of a height function leaves, `relative_load_errors`, are no more than noise.
    negligible_shares = (
        max(_NEGLIGIBLE_LOAD_SHARE, profile.relative_load_errors.load),
        max(_NEGLIGIBLE_STIFFNESS_SHARE, profile.relative_load_errors.stiffness),
    )
    try:
        # `piecewise_series_by_halving` resolves to 4e-15 of the size that it is given last.
        load_series, stiffness_series = (
            piecewise_series_by_halving(
                partial(load_or_stiffness, derivative_order=derivative_order),
                interval_ends,
                negligible_shares[derivative_order]
                / 4e-15
                * load_or_stiffness(u_of_reference_values, derivative_order),
            )
            for derivative_order in (0, 1)
        )
    except UnresolvedError as fault:
        raise InputError(
            f"profile: the function is too rough near x = {fault.high:.6g}: the load that a contact"
            " of this half-width carries is no smooth function; give `breaks`, or a smoother"
            " function"
        ) from fault
    return _SeriesBehindCorner(first_half_width, is_in_square_root, load_series, stiffness_series)


def _abel_integral(
    modulus: float,
    profile: CallableProfile,
    first_half_width: float,
    distance: Array,
    corners: tuple[float, ...],
    derivative_order: int,
) -> Array:
    """Load P [force per thickness] (`derivative_order` 0) or stiffness dP/da [stress] (1) of a
    contact of half-width a, an array like `distance`, by quadrature of the profile's slope h'.

        P     = E* a int cos(angle) h'(x) d angle,    x = a cos(angle), 0 < angle < pi/2
        dP/da = E* int cos(angle) (x h')' d angle

    Parameters
    ----------
    modulus
        E* [stress]
    first_half_width, distance
        a = first_half_width + distance: the distance from a corner keeps its digits [length]
    corners
        distances b from the middle to corners of the slope, descending: the integral is split there
        [length]
    """
    half_width = first_half_width + distance
    # cos(angle) = b/a; angle 0 for a corner outside of the contact
    corner_angles = []
    for b in corners:
        edge_distance_from_corner = np.maximum(distance + (first_half_width - b), 0.0)
        sqrt_of_square_difference = np.sqrt(edge_distance_from_corner * (half_width + b))
        corner_angles.append(np.arctan2(sqrt_of_square_difference, b))
    # Quadrature over the angle, cut at the corners into panels, (..., panels, nodes): `place` is
    # the angle of a node, `distance_from_end` its distance from pi/2.
    nodes = panel_nodes(np.zeros(half_width.shape), np.pi / 2, corner_angles)
    # cos(angle) as the sine of pi/2 - angle, which keeps its digits near pi/2
    complement_of_angle = np.where(
        nodes.place < 0.7, np.pi / 2 - nodes.place, nodes.distance_from_end
    )
    cosine = np.sin(complement_of_angle)
    half_width_column = half_width[..., None, None]
    x = half_width_column * cosine
    if derivative_order:
        # (x h')' = h' + x h''
        slope_factor = profile.slope(x) + profile.curvature_times_x(x)
    else:
        slope_factor = profile.slope(x) * half_width_column
    return np.asarray(modulus * np.sum(nodes.weight * cosine * slope_factor, axis=(-2, -1)))


def _flat_half_length(profile: CallableProfile, corners: tuple[float, ...]) -> float:
    """Half-length of the flat in the middle of a profile given by a function [length]; 0 if there
    is none.

    A flat ends at a corner of the slope, within which the slope is 0. A slope that falls towards 0
    without a corner is not flat.

    Parameters
    ----------
    profile
        slope h'(x); places x at which pieces of it meet (`corners`), and its end (`extent`)
    corners
        those of these places where h'' jumps, ascending [length]
    """
    # where a flat may end: the slope is 0 inside of some of them, out to `ends_of_zero_slope`
    places = np.array([*profile.corners, profile.extent])
    largest_slope = np.max(profile.slope(places))
    is_slope_zero_inside = profile.slope(places * 0.999) <= 1e-15 * float(largest_slope)
    ends_of_zero_slope = places[is_slope_zero_inside]
    corners_of_flat = [
        b for b in corners if len(ends_of_zero_slope) and b <= ends_of_zero_slope[-1] * (1 + 1e-9)
    ]
    if not corners_of_flat:
        return 0.0
    last_corner = corners_of_flat[-1]
    is_flat = profile.slope(last_corner * 0.9) <= 1e-13 * largest_slope
    return float(last_corner) if is_flat else 0.0


def _corners(profile: CallableProfile) -> tuple[float, ...]:
    """Distances b from the middle at which the curvature h'' of a profile jumps, ascending
    [length].

    They are among `profile.corners`, the places at which pieces of its slope meet: those where x
    h'' differs on both sides, at a distance of 1e-9 b, by more than a millionth of its size there.
    """
    jump_distances = []
    for b in profile.corners:
        # `curvature_times_x` is x h''
        x_curvature_before, x_curvature_behind = profile.curvature_times_x(
            np.array([b * (1 - 1e-9), b * (1 + 1e-9)])
        )
        x_curvature_size = (
            abs(x_curvature_before) + abs(x_curvature_behind) + float(profile.slope(np.array(b)))
        )
        if abs(x_curvature_before - x_curvature_behind) > 1e-6 * x_curvature_size + 1e-300:
            jump_distances.append(b)
    return tuple(jump_distances)


_KINDS: dict[type, _Kind] = {
    Hertz: _Kind(
        lambda modulus, p, datum_length: HertzContact(modulus, p.radius, datum_length),
        _convex_hertz,
    ),
    FlatRounded: _Kind.by_law(
        lambda modulus, p: law_of_flat_and_rounded(modulus, p.radius, p.flat_half_length),
        _convex_flat_rounded,
    ),
    PowerLaw: _Kind.by_law(
        lambda modulus, p: law_of_power(modulus, p.exponent, p.length, p.rise), _convex_power
    ),
    Compound: _Kind.by_law(
        lambda modulus, p: law_of_two_curvatures(
            modulus, p.inner_radius, p.outer_radius, p.inner_half_length
        ),
        _convex_compound,
    ),
    Wedge: _Kind.by_law(
        lambda modulus, p: law_of_two_curvatures(
            modulus, p.tip_radius, math.inf, p.tip_half_length
        ),
        _convex_wedge,
    ),
    EvenPolynomial: _Kind.by_law(
        lambda modulus, p: law_of_even_polynomial(modulus, p.length, p.rises), _convex_polynomial
    ),
    Tabulated: _Kind.by_law(law_of_table, _convex_table),
    CallableProfile: _Kind.by_law(law_of_function, _convex_function),
}
"""The functions that make contacts of each type of profile."""
