"""Unsymmetric contact: any convex profile under a tilt, and nested contact intervals under a load
that grows.

A contact interval under load P and tilt alpha is where h' + alpha has no mean over sqrt(c^2 - t^2)
and carries P. `CurvedProfile` takes averages over it by quadrature, `PiecewiseParabola` in closed
form, some tens of times as fast; tables have hundreds of knots.

# notation: b_j knots, J_j jumps of h'' there, k_0 and s_0 the curvature left of b_0 and the slope
#           at it; m, c centre and half-width of the contact, x = m + t, b_j = m + c cos(theta_j),
#           0 <= theta_j <= pi; alpha tilt, A = 2/E*; sums run over the knots

    h' = s_0 + k_0 (x - b_0) + sum J_j (x - b_j)_+

    0   = alpha + s_0 + k_0 (m - b_0) + (c/pi) sum J (sin - theta cos)
    A P = (c^2/2) [pi k_0 + sum J (theta - sin cos)]

Pressure, gap, approach and moment follow by integrating h'' over the contact. The parabola, flat
and rounded, compound, wedges with a rounded tip and tables, whose sides may be unequal, are such
profiles.

# notation: eps difference of the bulk strains; eta normal load, I(eta) contact interval of load eta
#           and tilt alpha_0 + kappa eta, m its centre, c its half-width, t = x - m; M(eta) memory
#           curve

Where tilt and bulk strain are the same affine function of the loads, alpha = alpha_0 + kappa P and
eps = eps_0 + kappa Q, the intervals I(eta) take the place of the flat punches of a symmetric
contact. They are nested while |kappa| <= A/(pi a). The memory curve is what it is without tilt and
bulk, and its integrals take other kernels:

    inside   dp/d eta = [1/pi - (kappa/A) t]/sqrt(c^2 - t^2),   q = int M' dp
    outside  s = (A/pi) int M' [arccosh(|t|/c) - (pi kappa/A) sgn(t) sqrt(t^2 - c^2)] d eta
    x = 0    U = (A/pi) int M' [ln(2 L/c) + (pi kappa/A) m] d eta
    m_q = int x q = int M' mu d eta,  mu = m - (pi kappa/(2 A)) c^2,  and int x p = int mu d eta
    W = closed-int Q dU - m_q d eps = -closed-int (U + kappa m_q) dQ

An increment of Q alone that is stuck on I would leave q symmetric about m; the increment kappa dQ
of bulk strain skews it as the increment kappa dP of tilt skews p. So q stays a sum of the same
increments that p is a sum of. No source is known for these intervals; kappa = 0 is the theorem of
Ciavarella and Jaeger for unsymmetric profiles, constant P the bulk stress of Nowell and Hills 1987.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError, NotFoundError, ProfileDataError
from scenes.array_types import Array
from scenes.chebyshev import PiecewiseSeries, UnresolvedError, piecewise_series_by_halving
from semi_analytic.quadrature import (
    GRADED_RULE,
    LogisticRule,
    crowded_nodes,
    gauss_rule,
    graded_nodes,
    panel_nodes,
)

# Iterations of Newton's method at most: about ten are taken. Sixty halvings of a bracket would do,
# where there is one.
_MOST_NEWTON_STEPS = 120
# Angle below which sin - theta cos = sum 2 k (-1)^(k + 1) theta^(2 k + 1)/(2 k + 1)! and theta -
# sin cos are summed as series.
_SMALL_ANGLE = 0.3
_ORDERS = np.arange(1.0, 9.0)
_FACTORIALS = np.array([float(math.factorial(2 * k + 1)) for k in range(1, 9)])
_SERIES_OF_MEAN_FUNCTION = -((-1.0) ** _ORDERS) * 2 * _ORDERS / _FACTORIALS
_SERIES_OF_LOAD_FUNCTION = -((-1.0) ** _ORDERS) * 4**_ORDERS / _FACTORIALS
# Relative error of m and c by their series, measured against the equations themselves.
_RELATIVE_ERROR_OF_SERIES = 1e-12
# Values at knots or quadrature nodes that are held in memory at a time.
_VALUES_AT_ONCE = 100_000
# Share of c^2 below which c^2 - t^2 is taken from the rise of the load: x is next to an edge.
_NEAR_EDGE_FRACTION = 0.1
# Share of P up to which the dissipation kernel is a quadrature over the load of the slip zone.
# Above, it is a difference of closed forms.
_SMALL_SLIP_FRACTION = 0.03


class Balance(NamedTuple):
    """Integrals over contacts of centre m and half-width c, one value for each contact; theta is
    the angle of x = m + c cos(theta), 0 <= theta <= pi.

    Attributes
    ----------
    mean_slope
        mean of h' over theta, which balances the tilt: it is -alpha
    load_product
        A P, A = 2/E* [length]
    curvature_integral, curvature_cosine_integral
        int h'' d theta and int h'' cos(theta) d theta [1/length]: they give the derivatives of mean
        slope and load by m and c
    """

    mean_slope: Array
    load_product: Array
    curvature_integral: Array
    curvature_cosine_integral: Array


class Angles(NamedTuple):
    """Angles theta of the knots of a profile, b = m + c cos(theta), with their sines and cosines:
    (..., n) of contacts of shape (...).
    """

    theta: Array
    sine: Array
    cosine: Array


class ConvexProfile(abc.ABC):
    """A profile h(x) that bends down nowhere, and its contact under any load and tilt.

    A contact is given by its centre m and half-width c. Subclasses hold h as parabolas or as
    functions.

    Attributes
    ----------
    knots
        (n,) ascending: where h'' is not smooth [length]
    typical_half_length
        a typical half-width of contact [length]
    extent
        ends of the profile [length]
    relative_roundoff
        relative error of h', which that of m and c follows
    """

    knots: Array
    typical_half_length: float
    extent: tuple[float, float]
    relative_roundoff: float = _RELATIVE_ERROR_OF_SERIES
    radius: float | None = None
    """Radius of curvature of a parabola about x = 0 [length]; None for other profiles."""

    @abc.abstractmethod
    def place_of_first_touch(self, tilt: ArrayLike) -> Array:
        """Place x where the profile under a tilt touches without load, h' + alpha = 0 [length]: the
        middle of it, infinite if there is none.
        """

    @property
    @abc.abstractmethod
    def corner_places(self) -> Array:
        """Knots at which h'' bends: an end of contact that meets one is no smooth function of the
        load.
        """

    @abc.abstractmethod
    def balance(self, m: Array, c: Array) -> Balance:
        """Mean slope, load and integrals of h'' over contacts of centre m and half-width c."""

    @property
    @abc.abstractmethod
    def _values_per_point(self) -> int:
        """Knots or quadrature nodes, each with one value in memory, for a point of one contact."""

    @abc.abstractmethod
    def _pressure(self, x: Array, m: Array, c: Array) -> Array: ...

    @abc.abstractmethod
    def _gap(self, x: Array, m: Array, c: Array) -> Array: ...

    def pressure(self, x: Array, m: Array, c: Array) -> Array:
        """pi A p(x), p >= 0 the pressure at x of contacts of centre m and half-width c; 0 outside.
        Arrays that broadcast.
        """
        return self._block_by_block(self._pressure, x, m, c)

    def gap(self, x: Array, m: Array, c: Array) -> Array:
        """Gap >= 0 at x of contacts of centre m and half-width c [length]; 0 inside. Arrays that
        broadcast.
        """
        return self._block_by_block(self._gap, x, m, c)

    @abc.abstractmethod
    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Normal approach of the point x = 0 minus (A P/pi) ln(2 L/c) [length]; A = 2/E*, L the
        distance of the point that does not move.
        """

    @abc.abstractmethod
    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """A times the moment, the integral of x p, of contacts of centre m and half-width c under
        a tilt, arrays of one shape [length^2]; A = 2/E*.
        """

    def _block_by_block(
        self, function: Callable[[Array, Array, Array], Array], *arguments: Array
    ) -> Array:
        """Values of an elementwise `function` of three arrays that broadcast, computed block by
        block along the first axis; the returned array has the broadcast shape.

        Each value is a sum over all knots or quadrature nodes of the profile. Their terms for all
        values at once would not fit into memory.
        """
        shape = np.broadcast_shapes(*(np.shape(argument) for argument in arguments))
        # All arrays with as many axes as the broadcast.
        arrays = []
        for argument in arguments:
            new_axes = (1,) * (len(shape) - np.ndim(argument))
            arrays.append(np.reshape(argument, new_axes + np.shape(argument)))
        if not shape:
            return np.array(function(*arrays))
        # A block has as many rows, places along the first axis, as need 100,000 terms at most
        # (_VALUES_AT_ONCE), but one row at least; _values_per_point: terms for one value.
        terms_per_row = max(self._values_per_point * math.prod(shape[1:]), 1)
        rows_at_once = max(_VALUES_AT_ONCE // terms_per_row, 1)
        values = np.empty(shape)
        for first_row in range(0, shape[0], rows_at_once):
            rows = slice(first_row, first_row + rows_at_once)
            array_rows = [array[rows] if len(array) > 1 else array for array in arrays]
            values[rows] = function(*array_rows)
        return values

    def contact_centre_and_half_width(
        self, load_product: ArrayLike, tilt: ArrayLike
    ) -> tuple[Array, Array]:
        """Centre m and half-width c of the contact under a load P and a tilt alpha [rad], arrays
        that broadcast [length].

        They minimise int h d theta + pi alpha m - A P ln(c). h(x) is the profile, at x = m + c
        cos(theta), 0 <= theta <= pi; A = 2/E*. `load_product` is A P [length]. Where P is not
        positive, m is where the profile touches first, and c is 0.

        Raises
        ------
        InputError
            Where the tilt exceeds the slope |h'| of a side everywhere, and where the sides do not
            rise enough to carry the load.
        ProfileDataError
            For a contact that reaches beyond the profile.
        """
        load_product, tilt = np.broadcast_arrays(
            np.asarray(load_product, dtype=float), np.asarray(tilt, dtype=float)
        )
        # Without load: the place of first touch, infinite if the tilt is steeper than the profile.
        centre = np.array(self.place_of_first_touch(tilt))
        half_width = np.zeros(load_product.shape)
        if not np.all(np.isfinite(centre)):
            raise InputError(
                "load: the tilt is steeper than the sides of the profile: it touches nowhere along"
                " its sides"
            )
        is_pressed = load_product > 0
        centre[is_pressed], half_width[is_pressed] = self._contact_by_newton(
            load_product[is_pressed], tilt[is_pressed], centre[is_pressed]
        )
        leftmost_edge = float(np.min(centre - half_width, initial=0.0))
        rightmost_edge = float(np.max(centre + half_width, initial=0.0))
        profile_begin, profile_end = self.extent
        # The profile may be passed by 1e-12 of its extent, for round-off.
        one_plus_slack = 1 + _RELATIVE_ERROR_OF_SERIES
        if (
            leftmost_edge < profile_begin * one_plus_slack
            or rightmost_edge > profile_end * one_plus_slack
        ):
            raise ProfileDataError(
                f"profile: the load needs a contact from {leftmost_edge:.6g} to"
                f" {rightmost_edge:.6g}, the profile goes from {profile_begin:.6g} to"
                f" {profile_end:.6g}"
            )
        return centre, half_width

    def _wide_contact(self, first_touch: Array) -> tuple[Array, Array]:
        """Centre and half-width, (n,) each [length], of a contact that is wider than the one
        looked for: the start of Newton's method. `first_touch` (n,) is where the profile touches
        without load.

        From there the residual of either end is nearly a convex function of that end, and hardly
        depends on the other. `knots` are places where h'' is not smooth; `typical_half_length` is
        that of a contact of this profile.
        """
        left_end = first_touch - self.typical_half_length
        right_end = first_touch + self.typical_half_length
        if len(self.knots):
            left_end = np.minimum(left_end, self.knots[0] - self.typical_half_length)
            right_end = np.maximum(right_end, self.knots[-1] + self.typical_half_length)
        return (left_end + right_end) / 2, (right_end - left_end) / 2

    def _contact_by_newton(
        self, load_product: Array, tilt: Array, first_touch: Array
    ) -> tuple[Array, Array]:
        """Centre m and half-width c of contacts under positive loads P and tilts alpha, (n,) each
        [length], by Newton's method.

        Two equations hold: the mean slope of the profile is -alpha, and the contact carries P. They
        state that a convex potential is least, int h d theta + pi alpha m - A P ln(c): its
        derivatives by m and by c are 0. A step that would overshoot the minimum is halved.
        InputError where 120 steps do not converge.

        Parameters
        ----------
        load_product
            (n,) A P, A = 2/E* [length]
        tilt
            (n,) [rad]
        first_touch
            (n,) where the profile touches without load [length]

        # notation: h gap between the unloaded faces, theta angle of a point x = m + c cos(theta) of
        #           the contact, h d theta is integrated from 0 to pi
        """
        centre, half_width = self._wide_contact(first_touch)
        # trial steps of centre and half-width from their last accepted values
        shift = 0 * first_touch
        widening = 0 * first_touch
        # |derivative of the potential along the step| where the step begins
        descent_before_step = np.full(first_touch.shape, np.inf)
        for _ in range(_MOST_NEWTON_STEPS):  # 120
            trial_centre = centre + shift
            trial_half_width = half_width + widening
            # mean slope, A times the load that the trial contact carries, integrals of h'' over it
            trial_balance = self.balance(trial_centre, trial_half_width)
            # derivative of the potential by the centre, and minus that by the half-width
            slope_residual = np.pi * (trial_balance.mean_slope + tilt)
            load_residual = (load_product - trial_balance.load_product) / trial_half_width
            # A step is halved where the potential rises behind it more than half as steeply as it
            # fell before it. That descent stays the one of the full step: shorter steps are
            # accepted sooner.
            ascent_behind_step = slope_residual * shift - load_residual * widening
            is_accepted = ascent_behind_step <= descent_before_step / 2
            centre = np.where(is_accepted, trial_centre, centre)
            half_width = np.where(is_accepted, trial_half_width, half_width)
            # Where Newton's method gives no step the half-width doubles.
            newton_shift, newton_widening = _newton_step(
                trial_balance, slope_residual, load_residual, trial_half_width, half_width
            )
            limited_shift, limited_widening = _limited_step(
                newton_shift, newton_widening, first_touch - centre, half_width
            )
            shift = np.where(is_accepted, limited_shift, shift / 2)
            widening = np.where(is_accepted, limited_widening, widening / 2)
            descent_before_step = np.where(
                is_accepted,
                np.abs(slope_residual * shift - load_residual * widening),
                descent_before_step,
            )
            # The next step would be about the power 3/2 of this one.
            largest_step = np.maximum(np.abs(shift), np.abs(widening))
            if np.all(largest_step <= 1e-10 * half_width + 1e-14 * np.abs(centre)):
                return centre + shift, half_width + widening
        raise InputError("profile: its sides do not rise enough to carry the load under this tilt")


def _limited_step(
    shift: Array, widening: Array, centre_to_first_touch: Array, half_width: Array
) -> tuple[Array, Array]:
    """Steps of the centre and of the half-width of contacts, (n,) each [length], shortened such
    that no end of contact moves too far.

    An end moves outwards by the half-width at most. It moves inwards by 0.9 of its distance from
    the place that touches without load at most.

    Parameters
    ----------
    shift, widening
        (n,) steps of centre and half-width without these limits [length]
    centre_to_first_touch
        (n,) x of the place that touches without load minus that of the centre of contact [length]
    half_width
        (n,) half-width of contact before the step [length]
    """
    left_move = np.clip(
        shift - widening,
        -half_width,
        0.9 * np.maximum(centre_to_first_touch + half_width, 0.0),
    )
    right_move = np.clip(
        shift + widening,
        0.9 * np.minimum(centre_to_first_touch - half_width, 0.0),
        half_width,
    )
    return (left_move + right_move) / 2, (right_move - left_move) / 2


def _newton_step(
    balance: Balance,
    slope_residual: Array,
    load_residual: Array,
    half_width: Array,
    fallback_widening: Array,
) -> tuple[Array, Array]:
    """Newton steps of the centre m and of the half-width c of contacts, (n,) each [length], from
    the residuals of the balances of slope and of load.

    A potential is least at the solution. The residual of slope is its derivative by m, that of load
    is minus its derivative by c. Where the Hessian is not positive the centre stays, and the
    half-width grows by `fallback_widening`.

    Parameters
    ----------
    balance
        `curvature_integral` int h'' d theta and `curvature_cosine_integral` int h'' cos(theta) d
        theta over each contact, x = m + c cos(theta) [1/length]
    slope_residual
        (n,) pi (mean of h' + alpha), alpha the tilt [1]
    load_residual
        (n,) missing load A (P - P of the contact)/c, A = 2/E* [1]
    half_width
        (n,) half-width c before the step [length]
    fallback_widening
        (n,) growth of the half-width where Newton's method gives no step [length]
    """
    curvature_integral = balance.curvature_integral
    curvature_cosine_integral = balance.curvature_cosine_integral
    off_diagonal_with_residual = curvature_cosine_integral + slope_residual / half_width
    # The residual belongs to the Jacobian, but may make its determinant negative: it counts only
    # where the determinant stays positive, with a margin.
    is_safely_convex = (
        curvature_integral * curvature_integral
        > 1.1 * off_diagonal_with_residual * curvature_cosine_integral
    )
    off_diagonal = np.where(is_safely_convex, off_diagonal_with_residual, curvature_cosine_integral)
    determinant = curvature_integral * curvature_integral - off_diagonal * curvature_cosine_integral
    is_convex = determinant > 0
    determinant = np.where(is_convex, determinant, 1.0)
    # The Jacobian has the curvature integral twice on its diagonal.
    centre_step = (
        -(slope_residual * curvature_integral + off_diagonal * load_residual) / determinant
    )
    half_width_step = (
        curvature_integral * load_residual + slope_residual * curvature_cosine_integral
    ) / determinant
    return np.where(is_convex, centre_step, 0.0), np.where(
        is_convex, half_width_step, fallback_widening
    )


@dataclass(frozen=True, eq=False)
class PiecewiseParabola(ConvexProfile):
    """A profile whose curvature h'' is constant between knots: parabolas side by side.

    Attributes
    ----------
    knots, curvature
        (n,) ascending [length]; (n + 1,) h'' between the knots and beyond [1/length]
    slope_at_first_knot, height_at_first_knot
        h' [1] and h [length] there
    extent
        ends of the profile [length]
    """

    knots: Array
    curvature: Array
    slope_at_first_knot: float
    height_at_first_knot: float
    extent: tuple[float, float] = (-np.inf, np.inf)

    @property
    def typical_half_length(self) -> float:  # type: ignore[override]
        return float(np.ptp(self.knots)) + 1e-3 / float(np.max(self.curvature))

    @cached_property
    def jumps(self) -> Array:
        """J, (n,): rise of h'' at each knot, to the right [1/length]."""
        return np.diff(self.curvature)

    @property
    def corner_places(self) -> Array:
        return self.knots[self.jumps != 0]

    @cached_property
    def radius(self) -> float | None:  # type: ignore[override]
        if not self.is_parabola or self.place_of_first_touch(0.0) != 0:
            return None
        return 1 / float(self.curvature[0])

    @cached_property
    def is_parabola(self) -> bool:
        """Whether h'' is the same everywhere: of such a profile m and c have closed forms."""
        return bool(np.all(self.jumps == 0))

    def angles(self, m: Array, c: Array) -> Angles:
        """Angles theta, sines and cosines of the n knots b = m + c cos(theta) of the profile over
        contacts of centre m and half-width c, (..., n) for m and c of shape (...).

        theta is 0 for knots beyond the right end, pi for those beyond the left one.

        A knot is a place where the curvature of the profile jumps.
        """
        distance_from_centre = self.knots - m[..., None]
        half_width = np.asarray(c)[..., None]
        unclipped_cosine = np.where(
            half_width > 0,
            distance_from_centre / np.where(half_width > 0, half_width, 1.0),
            np.sign(distance_from_centre),
        )
        cosine = np.clip(unclipped_cosine, -1.0, 1.0)
        return Angles(np.arccos(cosine), np.sqrt((1 - cosine) * (1 + cosine)), cosine)

    @cached_property
    def slopes(self) -> Array:
        """h' at the knots, (n,), ascending."""
        rises = np.cumsum(self.curvature[1:-1] * np.diff(self.knots))
        return np.concatenate([[self.slope_at_first_knot], self.slope_at_first_knot + rises])

    def place_of_first_touch(self, tilt: ArrayLike) -> Array:
        """Place x where the profile under a tilt alpha touches without load, h' + alpha = 0
        [length]; +-infinite where h' does not reach -alpha.

        h' is linear between knots, so that the place is interpolated between the knots on both
        sides. A straight part (h'' = 0) of the slope -alpha touches all along: its middle.
        """
        # slopes: h' at the knots, ascending; curvature: h'' between the knots and beyond.
        target_slope = -np.asarray(tilt, dtype=float)
        last_knot = len(self.knots) - 1
        first_knot_at_slope = np.searchsorted(self.slopes, target_slope, "left")
        first_knot_beyond = np.searchsorted(self.slopes, target_slope, "right")
        knot_before = np.clip(first_knot_at_slope - 1, 0, last_knot)
        curvature = self.curvature[first_knot_at_slope]
        slope_rise = target_slope - self.slopes[knot_before]
        with np.errstate(divide="ignore", invalid="ignore"):
            distance_from_knot = np.where(
                curvature > 0, slope_rise / curvature, np.copysign(np.inf, slope_rise)
            )
            place_between_knots = self.knots[knot_before] + distance_from_knot
        left_end_of_touch = self.knots[np.minimum(first_knot_at_slope, last_knot)]
        right_end_of_touch = self.knots[np.maximum(first_knot_beyond - 1, 0)]
        return np.where(
            first_knot_beyond > first_knot_at_slope,
            (left_end_of_touch + right_end_of_touch) / 2,
            place_between_knots,
        )

    def balance(self, m: Array, c: Array) -> Balance:
        """Mean slope, load and integrals of h'' over contacts of centre m and half-width c, in
        closed form: sums over the knots, with the jump J of h'' at each.

            mean slope = h'(m) + (c/pi) sum J (sin(theta) - theta cos(theta))
            A P        = (c^2/2) [pi h''(m) + sum s J (theta - sin(theta) cos(theta))]

        A knot is at m + s c cos(theta), 0 <= theta <= pi/2; its side s is 1 to the right of m, -1
        to the left. So h'' is counted from m outwards, and an end next to a knot keeps its digits.

        Returns
        -------
        Balance
            mean slope, which balances the tilt; A P with A = 2/E*; and int h'' d theta and int h''
            cos(theta) d theta, which give the derivatives of both by m and c
        """
        # `curvature`: h'' between the knots and beyond; `slopes`: h' at the knots; `jumps`: J at
        # each.
        number_of_parabola = np.searchsorted(self.knots, m)
        knot_before = np.maximum(number_of_parabola - 1, 0)
        curvature = self.curvature[number_of_parabola]
        distance_from_centre = self.knots - m[..., None]
        half_width = np.where(c > 0, c, 1.0)[..., None]
        # 1 - cos(theta): depth of the knot inside the nearer end, over c; exact next to the end
        relative_depth = np.clip(1 - np.abs(distance_from_centre) / half_width, 0.0, 1.0)
        theta = 2 * np.arcsin(np.sqrt(relative_depth / 2))
        sine = np.sqrt(relative_depth * (2 - relative_depth))
        # sin(theta) - theta cos(theta) and theta - sin(theta) cos(theta).
        side = np.where(distance_from_centre >= 0, 1.0, -1.0)
        mean_functions, load_functions = _mean_and_load_functions(theta, sine, 1 - relative_depth)
        slope_at_centre = self.slopes[knot_before] + curvature * (m - self.knots[knot_before])
        return Balance(
            mean_slope=c * (mean_functions @ self.jumps) / np.pi + slope_at_centre,
            load_product=c * c / 2 * (np.pi * curvature + (side * load_functions) @ self.jumps),
            curvature_integral=np.pi * curvature + (side * theta) @ self.jumps,
            curvature_cosine_integral=sine @ self.jumps,
        )

    def contact_centre_and_half_width(
        self, load_product: ArrayLike, tilt: ArrayLike
    ) -> tuple[Array, Array]:
        """Centre and half-width of the contact under a load P and a tilt alpha, arrays that
        broadcast [length]; in closed form if the profile is a single parabola, else by Newton's
        method.

        `load_product` is A P, A = 2/E* [length]. A contact without load has the half-width 0.
        """
        if not self.is_parabola:
            return super().contact_centre_and_half_width(load_product, tilt)
        # curvature[0]: h'' of the parabola; knots[0], slope_at_first_knot: a place on it and h'
        # there.
        curvature = self.curvature[0]
        load_product, tilt = np.broadcast_arrays(
            np.asarray(load_product, dtype=float), np.asarray(tilt, dtype=float)
        )
        centre = self.knots[0] - (self.slope_at_first_knot + tilt) / curvature
        half_width = np.sqrt(2 * np.maximum(load_product, 0.0) / (np.pi * curvature))
        return centre, half_width

    # --- what follows from a contact

    @property
    def _values_per_point(self) -> int:
        return len(self.knots)

    def _pressure(self, x: Array, m: Array, c: Array) -> Array:
        """Contact pressure times pi A at x, A = 2/E*, for contacts of centre m and half-width c,
        arrays that broadcast [1]; 0 outside.

            pi A p = pi h''_0 r + sum over knots of J [r theta_b - (b - x) ln|s_+/s_-|],
            s_+- = sin((theta_x +- theta_b)/2),  r = sqrt(c^2 - (x - m)^2)

        h''_0 is the curvature of the profile h left of all knots, J its jump at a knot b = m + c
        cos(theta_b), and x = m + c cos(theta_x). theta_b is 0 for knots to the right of the
        contact, pi to the left.
        """
        distance_from_centre = x - m
        curvature_left_of_knots = self.curvature[0]  # h''_0
        if self.is_parabola:
            difference_of_squares = np.maximum((c - x + m) * (c + x - m), 0.0)
            return np.asarray(np.pi * curvature_left_of_knots * np.sqrt(difference_of_squares))
        # angle theta_b of each knot, with sine and cosine, (..., knots)
        knot_angles = self.angles(m, c)
        r = np.sqrt(np.maximum((c - distance_from_centre) * (c + distance_from_centre), 0.0))[
            ..., None
        ]
        half_width = np.where(c > 0, c, 1.0)[..., None]
        distance_to_knot = self.knots - x[..., None]
        # sin(theta_x/2) cos(theta_b/2) and cos(theta_x/2) sin(theta_b/2), both times one factor:
        # s_+ is their sum, s_- their difference
        point_product = r / half_width * (1 + knot_angles.cosine)
        knot_product = knot_angles.sine * (1 + distance_from_centre[..., None] / half_width)
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log(
                np.abs((point_product + knot_product) / (point_product - knot_product))
            )
        # Knots whose term vanishes, or is not finite.
        is_zero_term = (distance_to_knot == 0) | (knot_angles.sine == 0) | ~np.isfinite(logarithm)
        logarithm = np.where(is_zero_term, 0.0, logarithm)
        terms_of_knots = r * knot_angles.theta - distance_to_knot * logarithm
        # `jumps`: J of each knot
        pressure = terms_of_knots @ self.jumps + np.pi * curvature_left_of_knots * r[..., 0]
        return np.where(r[..., 0] > 0, pressure, 0.0)

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        """Gap at x outside contacts of centre m and half-width c with the profile h, arrays that
        broadcast [length]; 0 inside.

        With F = d r - c^2 u, r = sqrt(d^2 - c^2), it is h''_0 F/2 plus for each knot b the jump J
        of h'' there times

            (x - b)_+^2/2 + [theta F - (x - b)^2 phi - s c sin(theta) (r - s c cos(theta) u)]/(2 pi)

        # notation: t = x - m, d = |t|, s sign of t, u = arccosh(d/c), h''_0 curvature left of all
        #           knots; b = m + c cos(theta) in the contact, theta = 0 for b to the right of it,
        #           pi to the left; tan(phi/2) = tan(theta/2)/tanh(u/2) where s > 0, and
        #           tan(theta/2) tanh(u/2) where s < 0
        """
        t = x - m
        # of each knot, (..., knots)
        theta, sine, cosine = self.angles(m, c)
        distance_from_centre = np.maximum(np.abs(t), c)
        r = np.sqrt((distance_from_centre - c) * (distance_from_centre + c))
        u = np.where(c > 0, np.arcsinh(r / np.where(c > 0, c, 1.0)), 0.0)
        parabola_term = distance_from_centre * r - c * c * u  # F
        side_of_contact = np.sign(t)[..., None]

        # phi/2 as the angle of a right triangle; leg_ratio = tanh(u/2)
        zeros = np.zeros(t.shape)
        leg_ratio = np.divide(
            r, distance_from_centre + c, out=zeros, where=distance_from_centre + c > 0
        )[..., None]
        opposite_leg = np.where(side_of_contact > 0, sine, leg_ratio * sine)
        adjacent_leg = np.where(side_of_contact > 0, leg_ratio, 1.0) * (1 + cosine)
        phi = 2 * np.arctan2(opposite_leg, adjacent_leg)
        phi = np.where(cosine >= 1, 0.0, phi)
        phi = np.where(cosine <= -1, np.pi, phi)
        distance_from_knot = x[..., None] - self.knots
        c_sine = c[..., None] * sine
        c_cosine = c[..., None] * cosine
        terms_of_knots = np.square(np.maximum(distance_from_knot, 0.0)) / 2
        terms_of_knots = terms_of_knots - distance_from_knot * distance_from_knot * phi / (
            2 * np.pi
        )
        factor_of_sine = r[..., None] - side_of_contact * c_cosine * u[..., None]
        terms_of_knots += (
            theta * parabola_term[..., None] - side_of_contact * c_sine * factor_of_sine
        ) / (2 * np.pi)
        # `jumps`: J of each knot; `curvature[0]`: h''_0
        gap = terms_of_knots @ self.jumps + self.curvature[0] / 2 * parabola_term
        return np.where(np.abs(t) > c, gap, 0.0)

    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Normal approach of the point x = 0 of contacts of centre m and half-width c under a
        tilt alpha, without its term (A P/pi) ln(2 L/c) [length]; A = 2/E*, L the distance of the
        point that does not move.

        It is the mean of h + alpha x over the angle theta, x = m + c cos(theta), with the profile
        h(x): that of the parabola left of all knots, plus what the jumps of h'' add.

        Each jump J of h'' at a knot b adds J/(2 pi) [theta (b - m)^2 + c^2 (theta/2 - 3/2 sin
        cos)], with the sine and cosine of the angle theta of that knot.
        """
        # Of each knot: 0 beyond the right end of the contact, pi beyond the left.
        theta, sine, cosine = self.angles(m, c)
        # Left of all knots h is a parabola: height, slope and curvature at the first knot.
        distance_from_first_knot = m - self.knots[0]
        distance_to_knot = self.knots - m[..., None]
        angle_functions = theta / 2 - 1.5 * sine * cosine
        sum_over_knots = (
            theta * distance_to_knot * distance_to_knot + np.square(c)[..., None] * angle_functions
        ) @ self.jumps
        mean_square = distance_from_first_knot * distance_from_first_knot + c * c / 2  # of x - b_0
        approach_of_parabola = (
            self.height_at_first_knot
            + self.slope_at_first_knot * distance_from_first_knot
            + self.curvature[0] / 2 * mean_square
        )
        return np.asarray(
            approach_of_parabola + np.asarray(tilt) * m + sum_over_knots / (2 * np.pi)
        )

    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Moment of the pressure about x = 0 times A, A int x p dx, of contacts of centre m and
        half-width c under a tilt alpha [length^2]; A = 2/E*.

        It is A P m plus the moment about the centre m: (pi/2) c^2 times the slope plus tilt at m of
        the parabola left of all knots, plus what the jumps of h'' at the knots add.
        """
        # Angle of each knot: 0 beyond the right end of the contact, pi beyond the left.
        theta, sine, cosine = self.angles(m, c)
        half_width = c[..., None]
        distance_to_knot = self.knots - m[..., None]
        angle_functions = sine - sine**3 / 3 - sine * cosine * cosine / 2
        sum_over_knots = (half_width * angle_functions - theta * distance_to_knot / 2) @ self.jumps
        # h' + alpha at m, of the parabola left of all knots
        slope_at_centre = (
            np.asarray(tilt) + self.slope_at_first_knot + self.curvature[0] * (m - self.knots[0])
        )
        load_product = self.balance(m, c).load_product  # A P
        return np.asarray(m * load_product + c * c * (sum_over_knots + np.pi / 2 * slope_at_centre))


def _mean_and_load_functions(theta: Array, sine: Array, cosine: Array) -> tuple[Array, Array]:
    """sin(theta) - theta cos(theta) and theta - sin(theta) cos(theta): what a jump of curvature at
    angle theta adds to the mean slope and to the load of a contact.

    Angles below 0.3 take power series of eight terms, since the differences would lose digits.

    Parameters
    ----------
    theta, sine, cosine
        angle of the jump at b = m + c cos(theta) in a contact of centre m and half-width c, with
        its sine and cosine; arrays of one shape
    """
    mean_function = sine - theta * cosine
    load_function = theta - sine * cosine
    is_small = theta < _SMALL_ANGLE
    if np.any(is_small):
        squared_angle = np.square(theta)
        cubed_angle = theta * squared_angle
        # _SERIES_OF_MEAN_FUNCTION, _SERIES_OF_LOAD_FUNCTION: coefficients of the power series in
        # theta^2 of both functions over theta^3.
        mean_series = cubed_angle * np.polynomial.polynomial.polyval(
            squared_angle, _SERIES_OF_MEAN_FUNCTION
        )
        load_series = cubed_angle * np.polynomial.polynomial.polyval(
            squared_angle, _SERIES_OF_LOAD_FUNCTION
        )
        mean_function = np.where(is_small, mean_series, mean_function)
        load_function = np.where(is_small, load_series, load_function)
    return mean_function, load_function


# Share of c, or of the distance to a knot, within which h'' replaces a difference quotient of h'.
_NEAR_NODE_FRACTION = 1e-5


@dataclass(frozen=True, eq=False)
class CurvedProfile(ConvexProfile):
    """A convex profile given by h, h' and h'': averages over theta, x = m + c cos(theta), cut at
    the knots.

    # notation: <f> = (1/pi) int_0^pi f(xi) d theta, xi = m + c cos(theta), t = xi - m; x = m +- c
    cosh(u) outside

        pi A p    = pi sqrt(c^2 - (x - m)^2) <(h'(xi) - h'(x))/(xi - x)>
        A int x p = pi <(m t + t^2 - c^2/2) h'>
        gap       = <+-c sinh(u) [(h(x) - h(xi))/(x - xi) - h'(xi)] - u t h'(xi)>
        approach  = <h> + alpha m + (A P/pi) ln(2 L/c)

    With h' = sum b_k cos(k theta) these are p = (1/A) sum b_k sin(k theta) and its potential, by
    Glauert's integrals.

    Attributes
    ----------
    height, gradient, second_derivative
        h [length], h' [1] and h'' [1/length] as functions of x
    rule
        quadrature over theta between two knots; `GRADED_RULE` for integrands singular at the knots
    exponent
        n of |x|^n near the knot x = 0
    relative_roundoff
        relative error of h'
    """

    knots: Array
    typical_half_length: float
    height: Callable[[Array], Array]
    gradient: Callable[[Array], Array]
    second_derivative: Callable[[Array], Array]
    rule: LogisticRule = GRADED_RULE
    exponent: float = 2.0
    extent: tuple[float, float] = (-np.inf, np.inf)
    relative_roundoff: float = _RELATIVE_ERROR_OF_SERIES

    @property
    def corner_places(self) -> Array:
        return self.knots

    def place_of_first_touch(self, tilt: ArrayLike) -> Array:
        """Place x where the profile under a tilt alpha touches without load, h' + alpha = 0
        [length]; infinite where h' does not reach -alpha.

        The profile is even in x and h' falls nowhere. The first and the last place of the slope
        -alpha are found by bisection, in an interval about x = 0. It is doubled until it holds
        them, up to 1e9 times `typical_half_length`, a typical half-width of contact. Their middle
        is returned.
        """
        target_slope = -np.asarray(tilt, dtype=float)
        half_interval = self.typical_half_length
        steepest_slope = np.max(np.abs(target_slope))
        while (
            self.gradient(np.array(half_interval)) < steepest_slope
            and half_interval < 1e9 * self.typical_half_length
        ):
            half_interval = 2 * half_interval
        # gradient: h' as a function of x. First place with h' >= -alpha, last one with h' <=
        # -alpha.
        left_bound, _ = self._bounds_by_bisection(target_slope, half_interval, np.greater_equal)
        _, right_bound = self._bounds_by_bisection(target_slope, half_interval, np.greater)
        is_reached = np.abs(target_slope) <= self.gradient(np.array(half_interval))
        return np.where(is_reached, (left_bound + right_bound) / 2, np.inf)

    def _bounds_by_bisection(
        self, target_slope: Array, half_interval: float, is_above: Callable[[Array, Array], Array]
    ) -> tuple[Array, Array]:
        """Bounds from left and right of the place where the slope h' of the profile passes a
        target [length], by 64 bisections of -half_interval < x < half_interval.

        `is_above(slope, target)` is true to the right of that place. `gradient` is h' as a function
        of x. All arrays have the shape of `target_slope`.
        """
        left_bound = np.full(target_slope.shape, -half_interval)
        right_bound = np.full(target_slope.shape, half_interval)
        for _ in range(64):
            middle = (left_bound + right_bound) / 2
            is_beyond = is_above(self.gradient(middle), target_slope)
            left_bound = np.where(is_beyond, left_bound, middle)
            right_bound = np.where(is_beyond, middle, right_bound)
        return left_bound, right_bound

    def _ends_of_smooth_parts(self, m: Array, c: Array) -> tuple[Array, Array]:
        """Ends of the parts of contacts between which h'' is smooth, as angles theta [rad] and as
        places x = m + c cos(theta) [length], (..., k + 2) each for k knots of the profile: right
        end of the contact, knots from right to left, left end.

        m and c are centres and half-widths, (..., 1). A knot outside a contact lies at the end
        that is next to it.
        """
        distance_to_knot = self.knots[::-1] - m
        knot_root = np.sqrt(np.maximum((c - distance_to_knot) * (c + distance_to_knot), 0.0))
        knot_theta = np.arctan2(knot_root, distance_to_knot)
        angles_of_part_ends = np.concatenate([0 * m, knot_theta, 0 * m + np.pi], axis=-1)
        clipped_knots = np.clip(distance_to_knot + m, m - c, m + c)
        places_of_part_ends = np.concatenate([m + c, clipped_knots, m - c], axis=-1)
        return angles_of_part_ends, places_of_part_ends

    def _weights_of_nodes(self, angle_spans: Array, places_of_part_ends: Array) -> Array:
        """Weights of quadrature nodes over the parts of contacts, (..., parts, nodes), for means
        over equal angles from 0 to pi.

        Beyond its outermost node the rule leaves out a tail of the integral. At the knot x = 0,
        where h'' is like |x|^(n - 2), n = `exponent`, the tail is a geometric series: the outermost
        weight takes it too. `angle_spans` (..., parts, 1) are the lengths of the parts [rad],
        `places_of_part_ends` (..., parts + 1) the places x of their ends.
        """
        weights = angle_spans * self.rule.weight / np.pi
        if len(self.knots):
            tail_exponent = (
                (self.exponent - 1) * self.rule.weight[0] / self.rule.distance_from_begin[0]
            )
            factor_of_tail = 1 + 1 / math.expm1(tail_exponent)
            weights[..., 0] *= np.where(places_of_part_ends[..., :-1] == 0, factor_of_tail, 1.0)
            weights[..., -1] *= np.where(places_of_part_ends[..., 1:] == 0, factor_of_tail, 1.0)
        return weights

    def _nodes_of_contact(self, m: Array, c: Array) -> tuple[Array, Array, Array]:
        """Quadrature over contacts of centre m and half-width c: places xi of the nodes, distances
        xi - m [length], and weights whose sum is 1, in a new last axis of all nodes.

        They give means over equal angles theta, xi = m + c cos(theta). The range 0 < theta < pi is
        cut at the knots of the profile, where h'' is not smooth; each part takes the same rule.
        """
        m, c = np.broadcast_arrays(m, c)
        m = m[..., None]
        c = c[..., None]
        angles_of_part_ends, places_of_part_ends = self._ends_of_smooth_parts(m, c)
        angle_spans = np.diff(angles_of_part_ends)[..., None]

        # A node is placed from the nearer end of its part, so that its distance from a knot keeps
        # its digits. `rule` is for the range [0, 1]: it has the distances of its nodes from 0,
        # `distance_from_begin`, and from 1, `distance_from_end`.
        is_nearer_begin = self.rule.distance_from_begin < 0.5

        def at_nearer_end(at_part_ends: Array) -> Array:
            """Of values at the part ends, for each node that of the end to which it is nearer."""
            return np.where(
                is_nearer_begin, at_part_ends[..., :-1, None], at_part_ends[..., 1:, None]
            )

        angle_from_nearer_end = np.where(
            is_nearer_begin,
            angle_spans * self.rule.distance_from_begin,
            -angle_spans * self.rule.distance_from_end,
        )
        sine_of_half = np.sin(angle_from_nearer_end / 2)
        cosine_of_half = np.sqrt(1 - sine_of_half * sine_of_half)

        # Of the angle at that end.
        sine = at_nearer_end(np.sin(angles_of_part_ends))
        cosine = at_nearer_end(np.cos(angles_of_part_ends))
        # c [cos(end) - cos(end + angle_from_nearer_end)] as a product
        distance_from_nearer_end = (
            2 * c[..., None] * sine_of_half * (sine * cosine_of_half + cosine * sine_of_half)
        )
        xi = at_nearer_end(places_of_part_ends) - distance_from_nearer_end
        weights = self._weights_of_nodes(angle_spans, places_of_part_ends)
        shape = (*xi.shape[:-2], xi.shape[-2] * xi.shape[-1])
        return xi.reshape(shape), (xi - m[..., None]).reshape(shape), weights.reshape(shape)

    def balance(self, m: Array, c: Array) -> Balance:
        """Mean slope, load and integrals of h'' over contacts of centre m and half-width c, arrays
        that broadcast, by quadrature over the angle theta of x = m + c cos(theta).

        `gradient` and `second_derivative` are h' and h'' of the profile as functions of x.

        Returns
        -------
        Balance
            mean of h', which balances the tilt; A P with A = 2/E* [length]; int h'' d theta and int
            h'' cos(theta) d theta [1/length]
        """
        # xi: quadrature nodes x of the contact, their distances x - m, and weights of the sum 1.
        xi, distance_from_centre, weights = self._nodes_of_contact(m, c)
        weighted_slope = weights * self.gradient(xi)
        weighted_curvature = np.pi * weights * self.second_derivative(xi)
        cosine = distance_from_centre / np.where(c > 0, c, 1.0)[..., None]
        return Balance(
            mean_slope=np.sum(weighted_slope, axis=-1),
            load_product=np.sum(np.pi * weighted_slope * distance_from_centre, axis=-1),
            curvature_integral=np.sum(weighted_curvature, axis=-1),
            curvature_cosine_integral=np.sum(weighted_curvature * cosine, axis=-1),
        )

    @property
    def _values_per_point(self) -> int:
        return (len(self.knots) + 1) * len(self.rule.distance_from_begin)

    def _pressure(self, x: Array, m: Array, c: Array) -> Array:
        """Contact pressure times pi A at x, A = 2/E*, for contacts of centre m and half-width c,
        arrays that broadcast [1]; 0 outside.

            pi A p = pi sqrt(c^2 - (x - m)^2) mean of (h'(xi) - h'(x))/(xi - x)

        The mean is over the angle theta of xi = m + c cos(theta). Where xi is close to x the
        quotient is h'' between them.
        """
        # quadrature nodes of the contact, with weights of the sum 1
        xi, _, weights = self._nodes_of_contact(m, c)
        x_column = np.asarray(x)[..., None]
        root_of_squares = np.sqrt(np.maximum((c - x + m) * (c + x - m), 0.0))
        distance_to_node = xi - x_column
        distances_to_knots = np.abs(x_column - self.knots)
        distance_to_next_knot = np.min(distances_to_knots, axis=-1, initial=np.inf, keepdims=True)
        # pairs of point and node nearer than 1e-5 of c and of the distance to the next knot
        near_pairs = np.nonzero(
            np.abs(distance_to_node)
            < _NEAR_NODE_FRACTION * np.minimum(distance_to_next_knot, c[..., None])
        )
        middles_of_pairs = (
            (x_column + distance_to_node / 2)[near_pairs]
            if len(near_pairs[0])
            else distance_to_node[near_pairs]
        )
        distance_to_node[near_pairs] = np.inf
        # `gradient`: h'
        slope_rise = self.gradient(xi) - self.gradient(x_column)
        quotient = slope_rise / np.where(distance_to_node == 0, np.inf, distance_to_node)
        quotient[near_pairs] = self.second_derivative(middles_of_pairs)
        return np.asarray(np.pi * root_of_squares * np.sum(weights * quotient, axis=-1))

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        """Gap at x outside contacts of centre m and half-width c, arrays that broadcast [length];
        0 inside.

            gap = mean of s c sinh(u) [(h(x) - h(xi))/(x - xi) - h'(xi)] - u (xi - m) h'(xi)

        The mean is over the angle theta of xi = m + c cos(theta). x = m + s c cosh(u): u > 0, and s
        is 1 to the right of the contact, -1 to the left.
        """
        # quadrature nodes of the contact, their distances xi - m, and weights of the sum 1
        xi, node_from_centre, weights = self._nodes_of_contact(m, c)
        point_from_centre = np.maximum(np.abs(x - m), c)
        # c sinh(u)
        root_of_squares = np.sqrt((point_from_centre - c) * (point_from_centre + c))
        u = np.where(c > 0, np.arcsinh(root_of_squares / np.where(c > 0, c, 1.0)), 0.0)
        x_column = np.asarray(x)[..., None]
        point_from_node = x_column - xi
        slope = self.gradient(xi)
        height_rise = self.height(x_column) - self.height(xi)
        chord_slope = np.divide(
            height_rise,
            point_from_node,
            out=np.zeros(point_from_node.shape),
            where=point_from_node != 0,
        )
        signed_root = (np.sign(x - m) * root_of_squares)[..., None]
        values_at_nodes = (
            signed_root * (chord_slope - slope) - u[..., None] * node_from_centre * slope
        )
        return np.asarray(np.sum(weights * values_at_nodes, axis=-1))

    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Normal approach of the point x = 0 of contacts of centre m and half-width c under a tilt
        alpha, without its term (A P/pi) ln(2 L/c) [length]; A = 2/E*, L the distance of the point
        that does not move.

        It is the mean of h + alpha x over the angle theta of x = m + c cos(theta); `height` is the
        profile h(x).
        """
        # xi: quadrature nodes of the contact; weights with the sum 1.
        xi, _, weight = self._nodes_of_contact(m, c)
        return np.asarray(np.sum(weight * self.height(xi), axis=-1) + np.asarray(tilt) * m)

    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Moment of the pressure about x = 0 times A, A int x p dx, of contacts of centre m and
        half-width c [length^2]; A = 2/E*.

            A int x p = pi mean of (m t + t^2 - c^2/2) h'(x),    t = x - m

        The mean is over the angle theta of x = m + c cos(theta); `gradient` is h'. The tilt adds
        nothing to it and is not used.
        """
        del tilt
        # xi: quadrature nodes of the contact, with t = xi - m and weights of the sum 1.
        xi, distance_from_centre, weights = self._nodes_of_contact(m, c)
        lever = (
            m[..., None] * distance_from_centre
            + distance_from_centre * distance_from_centre
            - c[..., None] ** 2 / 2
        )
        return np.asarray(np.pi * np.sum(weights * self.gradient(xi) * lever, axis=-1))


@dataclass(frozen=True, eq=False)
class NestedIntervals:
    """Contact intervals I(eta) of a convex profile under normal loads eta and tilts alpha_0 + kappa
    eta, by Chebyshev series over the load.

    Their centre m and half-width c are series of sqrt(eta - eta_b) above each load eta_b at which
    an end of contact meets a knot.

    Attributes
    ----------
    profile
        gap between the unloaded faces
    compliance
        A = 2/E* [1/stress]
    tilt_without_load, tilt_per_load
        alpha_0 [rad] and kappa [rad per force per thickness]
    largest_load
        up to which the series go [force per thickness]
    """

    profile: ConvexProfile
    compliance: float
    tilt_without_load: float
    tilt_per_load: float
    largest_load: float

    def exact_centre_and_half_width(self, load: ArrayLike) -> tuple[Array, Array]:
        """Centre m and half-width c of the contact under normal loads eta and the tilt alpha_0 +
        kappa eta that belongs to each [length], by equilibrium, not by the series over eta.
        """
        eta = np.asarray(load, dtype=float)
        return self.profile.contact_centre_and_half_width(
            self.compliance * eta, self.tilt_without_load + self.tilt_per_load * eta
        )

    @cached_property
    def largest_half_width(self) -> float:
        """c of I(largest_load) [length]."""
        return float(self.exact_centre_and_half_width(self.largest_load)[1])

    @cached_property
    def unloaded_centre_and_half_width(self) -> tuple[Array, Array]:
        """m and c of I(0) [length]: c is 0, m where the profile touches first."""
        return self.exact_centre_and_half_width(0.0)

    @cached_property
    def flat_face(self) -> tuple[float, float]:
        """Middle and half-width of a flat face, all of which touches without load [length]."""
        middle = float(self.unloaded_centre_and_half_width[0])
        if self.profile.radius is not None:
            return middle, 0.0
        return middle, float(self._series.half_width(0.0))

    @cached_property
    def corner_loads(self) -> Array:
        """Loads at which an end of I(eta) is at a knot, ascending."""
        loads = self.load_with_edge_at(self.profile.corner_places)
        return np.unique(loads[np.isfinite(loads) & (loads > 1e-12 * self.largest_load)])

    @cached_property
    def _series(self) -> _IntervalSeries:
        """Chebyshev series of the centre and the half-width of contact over the load eta, from 0 to
        the largest.

        The loads are cut where an end of contact meets a knot of the profile, since centre and
        half-width are not smooth there. Above each cut load eta_b they are smooth in v = sqrt(eta -
        eta_b). The ranges of v between the cuts are laid end to end on one axis, so that one series
        holds all of them.
        """
        # A corner load next to the largest load is left out.
        corner_loads = self.corner_loads[self.corner_loads < self.largest_load * (1 - 1e-9)]
        cut_loads = np.concatenate([[0.0], corner_loads, [self.largest_load]])
        # The length of a range of v is the root of its rise of load.
        cuts_on_axis = np.concatenate([[0.0], np.cumsum(np.sqrt(np.diff(cut_loads)))])
        centre_series = []
        half_width_series = []
        for lower_load, upper_load in pairwise(cut_loads.tolist()):
            series_of_centre, series_of_half_width = self._series_between(lower_load, upper_load)
            centre_series.append(series_of_centre)
            half_width_series.append(series_of_half_width)
        return _IntervalSeries(
            cut_loads[:-1],
            cuts_on_axis,
            _on_one_axis(centre_series, cuts_on_axis),
            _on_one_axis(half_width_series, cuts_on_axis),
        )

    def _series_between(
        self, lower_load: float, upper_load: float
    ) -> tuple[PiecewiseSeries, PiecewiseSeries]:
        """Chebyshev series of the centre m and half-width c of contact over v = sqrt(eta -
        lower_load), for loads eta between two neighbouring ones at which an end of contact meets a
        knot.

        Raises
        ------
        NotFoundError
            Where no series represents them to round-off.

        # notation: alpha_0 + kappa eta tilt under the load eta, `tilt_without_load` and
        #           `tilt_per_load`
        """
        range_of_v = np.array([0.0, math.sqrt(upper_load - lower_load)])
        # The halving stops where coefficients are below 4e-15 of this length, a tenth of the
        # round-off of a contact. Beside a flat the last digits of a contact are noise, as are those
        # of a profile with noise.
        value_scale = 0.1 * self.profile.relative_roundoff / 4e-15 * self.largest_half_width
        try:
            return (
                piecewise_series_by_halving(
                    lambda v: self.exact_centre_and_half_width(lower_load + v * v)[0],
                    range_of_v,
                    value_scale,
                ),
                piecewise_series_by_halving(
                    lambda v: self.exact_centre_and_half_width(lower_load + v * v)[1],
                    range_of_v,
                    value_scale,
                ),
            )
        except UnresolvedError as fault:
            raise NotFoundError(
                f"no contact was found under the tilt {self.tilt_without_load:.6g} and loads of"
                f" about {lower_load:.6g}"
            ) from fault

    def centre_and_half_width(self, load: ArrayLike) -> tuple[Array, Array]:
        """Centre m and half-width c of the contact [length] under normal loads eta and the tilt
        that belongs to each, by Chebyshev series over the load; in closed form of a parabola.

        Loads above the largest of the series count as the largest. Between two loads at which an
        end of contact meets a knot the series is one of v = sqrt(eta - eta_b), eta_b the lower of
        them. The ranges of v are laid end to end on one axis.
        """
        if self.profile.radius is not None:  # a parabola
            return self.exact_centre_and_half_width(load)
        eta = np.clip(np.asarray(load, dtype=float), 0.0, self.largest_load)
        series = self._series
        range_number = np.searchsorted(series.begin_loads, eta, side="right") - 1
        v = np.sqrt(eta - series.begin_loads[range_number])
        next_cut_on_axis = series.cuts_on_axis[range_number + 1]
        place_on_axis = np.minimum(series.cuts_on_axis[range_number] + v, next_cut_on_axis)
        half_width = np.maximum(series.half_width(place_on_axis), 0.0)
        return series.centre(place_on_axis), np.where(eta > 0, half_width, 0.0)

    def edge_movement(self, side: Array, load: Array, load_rise: Array) -> Array:
        """Distance by which one end of contact moves outwards while the load rises by `load_rise`
        to `load`, (n,) [length]; `load_rise` is at most `load`.

        It is the integral over the load of the rate of that end, of a parabola in closed form. The
        difference of two places of the end would be mere round-off where both are close.

        Parameters
        ----------
        side
            (n,) +1 for the right end, -1 for the left one
        load, load_rise
            (n,) [force per thickness]
        """
        parabola_radius = self.profile.radius
        if parabola_radius is None:
            return self._edge_movement_by_series(side, load, load_rise)
        _, half_width_after = self.exact_centre_and_half_width(load)
        _, half_width_before = self.exact_centre_and_half_width(load - load_rise)
        # per load: half-width by c^2 = (2/pi) A P R, and centre -R times the tilt
        widening_rate = (
            2 * self.compliance * parabola_radius / np.pi / (half_width_after + half_width_before)
        )
        return load_rise * (widening_rate - side * parabola_radius * self.tilt_per_load)

    def _edge_movement_by_series(self, side: Array, load: Array, load_rise: Array) -> Array:
        """Distance by which one end of contact moves outwards while the load rises by `load_rise`
        to `load`, (n,) [length]: the integral over the load of the derivatives of two series.

        These are the centre m and the half-width c of the contact, as functions of v = sqrt(eta -
        eta_b) above each cut load eta_b (`begin_loads`). The ranges of v are laid end to end on one
        axis. The end at `side` = +1 or -1, (n,), moves outwards at the rate dc + side dm.
        """
        series = self._series
        outward_movement = np.zeros(load.shape)
        # From the load downwards, one range of v in each pass, until the whole rise is integrated.
        range_number = np.searchsorted(series.begin_loads, load, side="right") - 1
        remaining_rise = load_rise
        upper_v = np.sqrt(load - series.begin_loads[range_number])
        while np.any(range_number >= 0):
            rise_in_range = np.minimum(remaining_rise, upper_v * upper_v)
            lower_v = np.sqrt(upper_v * upper_v - rise_in_range)
            v_step = rise_in_range / np.maximum(upper_v + lower_v, 1e-300)
            outward_movement += series.movement_in_range(side, range_number, upper_v, v_step)
            range_number = np.where(remaining_rise > rise_in_range, range_number - 1, -1)
            remaining_rise = remaining_rise - rise_in_range
            upper_v = series.cuts_on_axis[range_number + 1] - series.cuts_on_axis[range_number]
        return outward_movement

    def load_with_edge_at(self, x: Array) -> Array:
        """The normal load P at which the contact first reaches x, so that x is an end of it [force
        per thickness]; infinite where the contact under the largest load does not reach x.
        """
        widest_centre, widest_half_width = self.exact_centre_and_half_width(self.largest_load)
        is_reached = np.abs(x - widest_centre) <= widest_half_width * (1 + 1e-8)
        reached_x = x[is_reached]
        # +1 if x becomes the right end, -1 if the left one
        place_of_first_touch = float(self.profile.place_of_first_touch(self.tilt_without_load))
        side = np.where(reached_x < place_of_first_touch, -1.0, 1.0)
        half_width = self._half_width_with_end_at(reached_x, side)
        centre = reached_x - side * half_width
        loads = np.full(x.shape, np.inf)
        # `load_product`: A times the load that the contact carries, A = 2/E* the compliance
        loads[is_reached] = self.profile.balance(centre, half_width).load_product / self.compliance
        return np.where(loads <= self.largest_load * (1 + 1e-9), loads, np.inf)

    def _half_width_with_end_at(self, x: Array, side: Array) -> Array:
        """Half-width c of the contact that has an end at x, (n,) [length]: the right end where
        `side` is +1, the left one where it is -1. Its centre is x - side c.

        x is an end where the mean slope h' over the contact plus the tilt alpha_0 + kappa P is 0. P
        is the load that the contact carries. With x fixed, that sum changes its sign once as c
        grows. So c is found by Newton's method, between bounds that close in; a step beyond them is
        replaced by their middle.
        """
        # kappa/A, by which the tilt grows with A P
        tilt_over_compliance = self.tilt_per_load / self.compliance
        least_c = np.zeros(x.shape)
        largest_c = np.full(x.shape, 2.1 * self.largest_half_width)
        c = largest_c / 2
        for _ in range(_MOST_NEWTON_STEPS):  # 120
            # Of a trial contact: mean of h', A times the load that it carries, int h'' d theta and
            # int h'' cos(theta) d theta, theta the angle of a point at c cos(theta) from its
            # centre.
            balance = self.profile.balance(x - side * c, c)
            # mean slope plus tilt, times side: positive while c is too small
            slope_excess = side * (balance.mean_slope + self.tilt_without_load)
            slope_excess = slope_excess + side * tilt_over_compliance * balance.load_product
            # -d slope_excess/dc while x stays an end
            fall_rate = (balance.curvature_integral - side * balance.curvature_cosine_integral) * (
                1 / np.pi - side * tilt_over_compliance * c
            )
            least_c = np.where(slope_excess > 0, c, least_c)
            largest_c = np.where(slope_excess > 0, largest_c, c)
            newton_c = c + slope_excess / np.where(fall_rate > 0, fall_rate, np.inf)
            is_within_bounds = (fall_rate > 0) & (newton_c >= least_c) & (newton_c <= largest_c)
            new_c = np.where(is_within_bounds, newton_c, (least_c + largest_c) / 2)
            is_small_step = is_within_bounds & (np.abs(new_c - c) <= 1e-10 * c)
            is_done = is_small_step | (largest_c - least_c <= 4e-16 * self.largest_half_width)
            c = new_c
            if np.all(is_done):
                break
        return c


class _IntervalSeries(NamedTuple):
    """Chebyshev series of the contact's centre and half-width [length] on one axis, on which the
    ranges of v = sqrt(eta - eta_b) between neighbouring cut loads eta_b lie end to end.

    Attributes
    ----------
    begin_loads
        (k,) load eta_b at which each range begins [force per thickness]
    cuts_on_axis
        (k + 1,) places of the ends of the ranges on the axis [square root of a load]
    """

    begin_loads: Array
    cuts_on_axis: Array
    centre: PiecewiseSeries
    half_width: PiecewiseSeries

    def movement_in_range(
        self, side: Array, range_number: NDArray[np.intp], upper_v: Array, v_step: Array
    ) -> Array:
        """Distance by which an end of contact moves outwards within one range of v, (n,) [length]:
        the integral of its rate over v, by eight Gauss points.

        Parameters
        ----------
        side
            (n,) +1 for the right end, -1 for the left one
        range_number
            (n,) number of the range
        upper_v, v_step
            (n,) v at the larger load, and its growth up to there [square root of a load]
        """
        gauss_nodes, gauss_weights = gauss_rule(8)
        lower_cut_on_axis = self.cuts_on_axis[range_number][:, None]
        upper_cut_on_axis = np.nextafter(self.cuts_on_axis[range_number + 1], 0.0)[:, None]
        place_on_axis = np.clip(
            lower_cut_on_axis + (upper_v[:, None] - v_step[:, None] * gauss_nodes),
            lower_cut_on_axis,
            upper_cut_on_axis,
        )
        half_width_rate = self.half_width.derivative(place_on_axis)
        centre_rate = self.centre.derivative(place_on_axis)
        outward_rate = half_width_rate + side[:, None] * centre_rate
        return np.asarray(v_step * np.sum(gauss_weights * outward_rate, axis=1))


def _on_one_axis(series: list[PiecewiseSeries], cuts_on_axis: Array) -> PiecewiseSeries:
    """Join the piecewise Chebyshev series of k ranges to one series on a common axis: range number
    i begins at `cuts_on_axis[i]`; the k + 1 ends of the ranges are given.

    A piecewise series has `interval_ends`, and `coefficients`, one column for each interval. The
    ends of each range count from its begin.
    """
    interval_ends = [np.zeros(1)]
    for series_of_range, begin_on_axis in zip(series, cuts_on_axis[:-1], strict=True):
        interval_ends.append(series_of_range.interval_ends[1:] + begin_on_axis)
    coefficients = np.concatenate(
        [series_of_range.coefficients for series_of_range in series], axis=1
    )
    return PiecewiseSeries(np.concatenate(interval_ends), coefficients)


@dataclass(frozen=True, eq=False)
class TiltedProfile:
    """Contact of a convex profile under tilt alpha_0 + kappa eta that follows the load eta: contact
    intervals, pressure, and the kernels that the memory curve takes. Arrays broadcast; points x
    carry their sign.

    Attributes
    ----------
    intervals
        contact intervals I(eta)
    datum_length
        L, distance of the point that does not move, from which displacements count [length]
    kernel_quantity
        what `log_datum_ratio`, `approach_integral` and `approach_moment` give by an increment of
        M(eta): "displacement", the tangential displacement U over A/pi; "conjugate_displacement",
        U + kappa m_q over A/pi, which is conjugate to Q in the friction work W; or "shear_moment",
        the moment m_q of the shear about x = 0
    """

    intervals: NestedIntervals
    datum_length: float
    kernel_quantity: Literal["displacement", "conjugate_displacement", "shear_moment"] = (
        "displacement"
    )
    half_width_may_be_steep: ClassVar[bool] = False
    corner_half_widths: ClassVar[tuple[float, ...]] = ()
    least_half_width: ClassVar[float] = 0.0
    tangential_fraction: ClassVar[float] = 1.0
    """Rise of Q over that of the load in whose terms the memory curve is: 1, or 0 where bulk strain
    alone changes, as in `OppositeSlip`.
    """

    @property
    def has_closed_form(self) -> bool:
        """Whether contacts are known in closed form, without series."""
        return self.profile.radius is not None

    @property
    def relative_roundoff(self) -> float:
        """Relative error of the centre m and half-width c of contact."""
        return self.profile.relative_roundoff

    @property
    def profile(self) -> ConvexProfile:
        """The profile."""
        return self.intervals.profile

    @property
    def _compliance(self) -> float:
        """A = 2/E* [1/stress]."""
        return self.intervals.compliance

    @cached_property
    def pressure_skewness(self) -> float:
        """pi kappa/A [1/length]: the skewness of an increment of pressure by load and tilt.

        dp/d eta = (1 - pressure_skewness t)/(pi sqrt(c^2 - t^2)),  t = x - m
        """
        return float(np.pi * self.intervals.tilt_per_load / self._compliance)

    def centre_and_half_width(self, load: ArrayLike) -> tuple[Array, Array]:
        """Centre m and half-width c of I(eta) [length] at loads eta."""
        return self.intervals.centre_and_half_width(load)

    @property
    def corner_loads(self) -> Array:
        """Loads at which an end of I(eta) is at a knot, ascending."""
        return self.intervals.corner_loads

    def is_nested(self, load: float) -> bool:
        """Whether every contact interval up to the normal load P = `load` contains those of smaller
        loads.
        """
        return bool(abs(self.pressure_skewness) * self.half_width(load) <= 1 + 1e-11)

    def centre(self, load: ArrayLike) -> Array:
        """m(eta) [length]."""
        return self.centre_and_half_width(load)[0]

    def half_width(self, load: ArrayLike) -> Array:
        """c(eta) [length]."""
        return self.centre_and_half_width(load)[1]

    def interval(self, load: ArrayLike) -> Array:
        """Ends of I(eta) [length], a new last axis."""
        m, c = self.centre_and_half_width(load)
        return np.stack([m - c, m + c], axis=-1)

    def edge_advance(self, load: ArrayLike) -> Array:
        """The parameter of an interval that kernels take: here its load [force per thickness]."""
        return np.asarray(load, dtype=float)

    load_at = edge_advance

    def load(self, half_width: ArrayLike) -> Array:
        """P_x, the load at which a point x = `half_width` is an end of contact [force per
        thickness]; infinite where the largest contact does not reach it.
        """
        return self.intervals.load_with_edge_at(np.asarray(half_width, dtype=float))

    # --- normal contact under a load and a tilt

    def centre_and_half_width_under(self, load: Array, tilt: Array) -> tuple[Array, Array]:
        """Centre m and half-width c of contacts under loads and tilts, (n,) each [length]."""
        return self.profile.contact_centre_and_half_width(self._compliance * load, tilt)

    def pressure_over(self, x: Array, m: Array, c: Array) -> Array:
        """Pressure p >= 0 (n, k) at points x (k,) of contacts of centre m and half-width c, (n,)
        each [stress].
        """
        pressure = np.maximum(self.profile.pressure(x, m[:, None], c[:, None]), 0.0)
        return np.asarray(pressure / (np.pi * self._compliance))

    def approach(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """Normal approach of the point x = 0 of n contacts, positive when pressed, (n,) [length].

        Parameters
        ----------
        m, c
            (n,) centre and half-width [length]
        load, tilt
            (n,) P [force per thickness] and tilt alpha [rad]
        """
        # The profile gives it without (A P/pi) ln(2 L/c), L the datum length, A = 2/E*.
        approach_without_logarithm = self.profile.approach(m, c, tilt)
        return approach_without_logarithm + self._compliance / np.pi * load * self.logarithm(c)

    def moment(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """Moment int x p dx of the pressure about x = 0, of contacts (n,) [force]."""
        del load
        return self.profile.moment(m, c, tilt) / self._compliance

    def tilt_under(self, load: Array, moment: Array) -> Array:
        """Tilt [rad] under which contacts under loads (n,) have given moments (n,), int x p dx
        [force], by Newton's method; 0 where there is no load.

        A larger tilt moves the contact to the left, and the moment falls. So the tilt lies between
        the largest one with too large a moment and the least one with too small a moment; steps
        beyond these bounds are replaced by their middle.

        Raises
        ------
        InputError
            For a moment that the profile carries at no tilt.
        NotFoundError
            Where the steps do not converge.
        """
        load = np.maximum(load, 0.0)
        moment = np.where(load > 0, moment, 0.0)
        if self.profile.radius is not None:  # a parabola: the contact is centred at -radius tilt
            return -moment / (self.profile.radius * np.where(load > 0, load, np.inf))

        # Each pair of load and moment is solved once.
        distinct_pairs, pair_number = np.unique(
            np.stack([load, moment]), axis=1, return_inverse=True
        )
        load, moment = distinct_pairs
        least_tilt = np.full(load.shape, -np.inf)
        largest_tilt = np.full(load.shape, np.inf)
        tilt = np.zeros(load.shape)
        for _ in range(_MOST_NEWTON_STEPS):  # 120
            centre, contact_half_width = self.centre_and_half_width_under(load, tilt)
            moment_excess = self.moment(centre, contact_half_width, load, tilt) - moment
            least_tilt = np.where(moment_excess > 0, tilt, least_tilt)
            largest_tilt = np.where(moment_excess > 0, largest_tilt, tilt)
            # A change d alpha of tilt adds -(d alpha/A) t/sqrt(c^2 - t^2) to p, with t = x - m, m
            # the centre, c the half-width and A = 2/E*: so the moment falls by pi c^2/(2 A) per
            # tilt.
            half_width = np.where(contact_half_width > 0, contact_half_width, 1.0)
            newton_step = 2 * self._compliance * moment_excess / (np.pi * half_width**2)
            # No step moves a contact by more than about a third of it.
            longest_step = self._compliance * load / (4 * half_width)
            new_tilt = tilt + np.clip(newton_step, -longest_step, longest_step)
            is_within_bounds = (new_tilt >= least_tilt) & (new_tilt <= largest_tilt)
            new_tilt = np.where(is_within_bounds, new_tilt, (least_tilt + largest_tilt) / 2)
            tilt_change = np.abs(new_tilt - tilt)
            tilt = new_tilt
            if np.all(tilt_change <= 1e-9 * longest_step):
                return np.where(load > 0, tilt, 0.0)[pair_number.ravel()]
        raise NotFoundError(
            "load: no tilt was found at which the contact carries the moment that is stated"
        )

    # --- kernels: fields of a unit increment of load or of M on I(eta), and their integrals

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Pressure p >= 0 at x under loads [stress], 0 outside the contact."""
        scaled_pressure = self.profile.pressure(
            np.asarray(x, dtype=float), *self.intervals.centre_and_half_width(load)
        )
        return np.asarray(np.maximum(scaled_pressure, 0.0) / (np.pi * self._compliance))

    pressure_rise = pressure

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """First moment of the pressure over the load, not over x: the integral of eta dp(x, eta)
        over loads eta from 0 to `load` [stress times force per thickness]. p(x, eta) is the
        pressure at x under the load eta; `x` and `load` broadcast.

        By parts it is load p(x, load) - int p d eta, since p is 0 before the contact reaches x. The
        integral is by quadrature.
        """
        x, load = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(load, dtype=float))
        # self.load(x): load at which the contact reaches x, infinite if it never does.
        eta, weights = self._nodes_over_load(np.minimum(self.load(x), load), load)
        integral_of_pressure = np.sum(weights * self.pressure(x[..., None], eta), axis=-1)
        return load * self.pressure(x, load) - integral_of_pressure

    def _nodes_over_load(self, begin: Array, end: Array) -> tuple[Array, Array]:
        """Quadrature nodes and weights on the loads from `begin` to `end` [force per thickness], in
        a new last axis; the range is cut at loads at which an end of contact meets a knot.
        """
        if not len(self.corner_loads):  # nowhere to cut
            return graded_nodes(begin, end)
        nodes_of_panels = panel_nodes(begin, end, self.corner_loads)
        shape_with_nodes = (*np.shape(end), -1)
        return nodes_of_panels.place.reshape(shape_with_nodes), nodes_of_panels.weight.reshape(
            shape_with_nodes
        )

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Integral of the kernel of slip over loads from 0 to `load`, at points x that are not in
        contact [force per thickness]: pi/A times the decrease of the gap at x, arrays that
        broadcast.

        A = 2/E*. For a point in contact the integral ends where the contact reaches it, and the gap
        under the load is 0.
        """
        x = np.asarray(x, dtype=float)
        # Gap without load, and under each load; both from centre and half-width of the contact.
        gap_before = self.profile.gap(x, *self.intervals.unloaded_centre_and_half_width)
        gap_after = self.profile.gap(x, *self.intervals.centre_and_half_width(load))
        return np.maximum(gap_before - gap_after, 0.0) * np.pi / self._compliance

    def slip_integral_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """First moment of the slip kernel K over the load: the integral of eta K(x, eta) over loads
        eta from 0 to `load`, or up to that at which the contact reaches x, if this is smaller.
        `x` and `load` broadcast [force^2 per thickness^2].

        K is the kernel of slip, `arccosh_ratio`: pi/A times the slip at x by a unit of tangential
        force on the contact interval of the load eta. By quadrature.
        """
        x, load = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(load, dtype=float))
        # self.load(x): load at which the contact reaches x, infinite if it never does.
        eta, weights = self._nodes_over_load(np.zeros(load.shape), np.minimum(load, self.load(x)))
        slip_kernel = self.arccosh_ratio(x[..., None], 0.0, eta)
        return np.asarray(np.sum(weights * eta * slip_kernel, axis=-1))

    def arccosh_ratio(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """The kernel of slip: pi/A times the slip s at points x outside, by a unit of the
        tangential force M on the contact interval under the normal load `advance` [1]; 0 inside.

            tangential_fraction arccosh(|t|/c) - pressure_skewness sgn(t) sqrt(t^2 - c^2)

        t = x - m, m is the centre of the interval, c its half-width. The skew term is that of bulk
        strain or tilt in proportion to the load: `pressure_skewness` = pi kappa/A, kappa the tilt
        per load, A = 2/E*. `tangential_fraction` is 1, but 0 where bulk strain alone changes.
        `excess` is not used.
        """
        del excess
        m, c = self.centre_and_half_width(advance)
        t = np.asarray(x, dtype=float) - m
        root_of_squares = np.sqrt(np.maximum((np.abs(t) - c) * (np.abs(t) + c), 0.0))
        arccosh = np.arcsinh(root_of_squares / np.where(c > 0, c, np.inf))
        return (
            self.tangential_fraction * arccosh
            - self.pressure_skewness * np.sign(t) * root_of_squares
        )

    def inverse_root(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """The kernel of shear: pi times the traction at points x by a unit of tangential load on
        the contact interval of load `advance` [1/length]; 0 outside.

            (tangential_fraction - pressure_skewness t)/sqrt((c - t)(c + t)),  t = x - m

        m is the centre of the interval, c its half-width. The skew term is that of bulk strain or
        tilt in proportion to the load: `pressure_skewness` = pi kappa/A, kappa the tilt per load, A
        = 2/E*. `tangential_fraction` is 1, but 0 where bulk strain alone changes.

        Parameters
        ----------
        x
            points, which carry their sign [length]
        excess
            `advance` minus the load at which an end of contact reaches x [force per thickness]
        advance
            load of the interval [force per thickness]
        """
        m, c = self.centre_and_half_width(advance)
        places = np.asarray(x, dtype=float)
        load_rise_since_x = np.asarray(excess, dtype=float)
        t = places - m
        difference_of_squares = (c - t) * (c + t)
        # Next to an edge c - |t| loses digits. There it is the distance by which the edge has moved
        # beyond x, but not in a flat face, which touches all at once without load.
        face_middle, face_half_width = self.intervals.flat_face
        is_beside_face = np.abs(places - face_middle) >= face_half_width
        is_near_edge = difference_of_squares < _NEAR_EDGE_FRACTION * c * c
        needs_edge_movement = is_near_edge & (load_rise_since_x > 0) & is_beside_face
        if np.any(needs_edge_movement):
            edge_side, interval_load, load_rise, half_width = (
                np.broadcast_to(values, needs_edge_movement.shape)[needs_edge_movement]
                for values in (np.sign(t), advance, load_rise_since_x, c)
            )
            distance_to_edge = self.intervals.edge_movement(edge_side, interval_load, load_rise)
            difference_of_squares[needs_edge_movement] = distance_to_edge * (
                2 * half_width - distance_to_edge
            )
        return (self.tangential_fraction - self.pressure_skewness * t) / np.sqrt(
            np.where(difference_of_squares > 0, difference_of_squares, np.inf)
        )

    def logarithm(self, c: Array) -> Array:
        """ln(2 L/c); 0 for c = 0, where it is multiplied by the load."""
        return np.log(2 * self.datum_length / np.where(c > 0, c, 2 * self.datum_length))

    def log_datum_ratio(self, load: ArrayLike) -> Array:
        """Rate of the quantity that `kernel_quantity` names, per unit of the tangential force M on
        the contact interval under `load`; an array of the shape of `load`.

        "displacement": phi ln(2 L/c) + (pi kappa/A) m, pi/A times the rate of U [1].
        "conjugate_displacement": phi times that, plus (pi kappa/A) mu for kappa m_q [1].
        "shear_moment": mu = phi m - (pi kappa/(2 A)) c^2, lever of the shear about x = 0 [length].

        phi = `tangential_fraction`: 1, but 0 where bulk strain alone changes, with Q = 0.

        # notation: A = 2/E*, L datum length of displacements, U tangential displacement, m and c
        #           centre and half-width of the interval, kappa tilt per load, m_q moment of the
        #           shear about x = 0; pressure_skewness = pi kappa/A
        """
        m, c = self.centre_and_half_width(load)
        moment_arm = self.tangential_fraction * m - self.pressure_skewness * c * c / 2
        if self.kernel_quantity == "shear_moment":
            return moment_arm
        # logarithm: ln(2 L/c)
        displacement_rate = (
            self.tangential_fraction * self.logarithm(c) + self.pressure_skewness * m
        )
        if self.kernel_quantity == "conjugate_displacement":
            return (
                self.tangential_fraction * displacement_rate + self.pressure_skewness * moment_arm
            )
        return displacement_rate

    def approach_integral(self, load: ArrayLike) -> Array:
        """Integral over loads from 0 to `load` of the kernel that `kernel_quantity` names, in
        closed form; an array of the shape of `load`.

        - "shear_moment": the moment of the pressure [force];
        - "displacement": pi/A times the normal approach since no load [force per thickness];
        - "conjugate_displacement": that plus pi kappa/A times the moment.

        # notation: A = 2/E*, kappa tilt per load, pressure_skewness = pi kappa/A
        """
        load = np.asarray(load, dtype=float)
        centre, half_width = self.intervals.centre_and_half_width(load)
        tilt_without_load = self.intervals.tilt_without_load
        tilt = tilt_without_load + self.intervals.tilt_per_load * load
        # The profile gives A times the moment of the pressure.
        moment = self.profile.moment(centre, half_width, tilt) / self._compliance
        if self.kernel_quantity == "shear_moment":
            return moment
        # The profile gives the approach without (A P/pi) ln(2 L/c), L the datum length.
        approach_without_load = self.profile.approach(
            *self.intervals.unloaded_centre_and_half_width, tilt_without_load
        )
        approach_under_load = self.profile.approach(centre, half_width, tilt)
        approach_rise = approach_under_load - approach_without_load
        scaled_approach = np.pi / self._compliance * approach_rise + load * self.logarithm(
            half_width
        )
        if self.kernel_quantity == "conjugate_displacement":
            return scaled_approach + self.pressure_skewness * moment
        return scaled_approach

    def approach_moment(self, load: ArrayLike) -> Array:
        """First moment over the load of the kernel `log_datum_ratio`: its integral with eta in
        front, over loads eta from 0 to `load`, by quadrature; an array of the shape of `load`.
        """
        eta, weight = self._nodes_over_load(np.zeros(np.shape(load)), np.asarray(load, dtype=float))
        return np.asarray(np.sum(weight * eta * self.log_datum_ratio(eta), axis=-1))

    def dissipation_kernel(self, load: ArrayLike, slip_zone_load: ArrayLike) -> Array:
        """Lam(P, P_c) >= 0 [force per thickness]: the kernel by which slip zones add to the
        friction work W.

            Lam = int_{P_c}^P [r(P_c) - r(eta)] d eta

        P = `load`, and P_c = P - `slip_zone_load` is the load whose contact interval is the stick
        zone. r is pi/A times the rate of U + kappa m_q per unit of M, U being the tangential
        displacement, m_q the moment of the shear, kappa the tilt per load.

        # notation: M tangential force on a contact interval, A = 2/E*
        """
        load, slip_zone_load = np.broadcast_arrays(
            np.asarray(load, dtype=float), np.asarray(slip_zone_load, dtype=float)
        )
        # Its `log_datum_ratio` is r, its `approach_integral` that of r from 0 to a load.
        conjugate_contact = replace(self, kernel_quantity="conjugate_displacement")
        stick_edge_load = np.maximum(load - slip_zone_load, 0.0)
        rate_at_stick_edge = conjugate_contact.log_datum_ratio(stick_edge_load)
        integral_to_load = conjugate_contact.approach_integral(load)
        integral_to_stick_edge = conjugate_contact.approach_integral(stick_edge_load)
        kernel = np.array(
            slip_zone_load * rate_at_stick_edge - (integral_to_load - integral_to_stick_edge)
        )
        # Below 3 % of P the difference of integrals loses digits: quadrature over the slip zone
        # instead.
        is_small_slip = slip_zone_load < _SMALL_SLIP_FRACTION * load
        if np.any(is_small_slip):
            eta, weights = crowded_nodes(stick_edge_load[is_small_slip], load[is_small_slip])
            rate_column = rate_at_stick_edge[is_small_slip][:, None]
            rate_fall = rate_column - conjugate_contact.log_datum_ratio(eta)
            kernel[is_small_slip] = np.sum(weights * rate_fall, axis=-1)
        return np.maximum(kernel, 0.0)

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Error of the values that the kernel method `name` returns for its `arguments`, in their
        units: by the round-off of the contact's centre m and half-width c.

        It is the relative round-off times the size of the value. `dissipation_kernel` is a
        difference of larger numbers: there the load, its first argument, is added to the size.
        """
        size = np.abs(getattr(self, name)(*arguments))
        if name == "dissipation_kernel":
            size = size + np.abs(arguments[0])
        return self.relative_roundoff * size
