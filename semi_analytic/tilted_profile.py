"""Unsymmetric contact: any convex profile under a tilt, and families of nested contact intervals.

A contact interval under load P and tilt alpha is where h' + alpha has no mean over sqrt(c^2 - t^2)
and carries P. `CurvedProfile` takes averages over it by quadrature, `PiecewiseParabola` in closed
form, some tens of times as fast; tables have hundreds of knots.

# notation: b_j knots, J_j jumps of h'' there, k_0 and s_0 the curvature left of b_0 and the slope
#           at it; m, c centre and half-length of the contact, x = m + t, b_j = m + c cos(theta_j),
#           0 <= theta_j <= pi; alpha tilt, A = 2/E*; sums run over the knots

    h' = s_0 + k_0 (x - b_0) + sum J_j (x - b_j)_+

    0   = alpha + s_0 + k_0 (m - b_0) + (c/pi) sum J (sin - theta cos)
    A P = (c^2/2) [pi k_0 + sum J (theta - sin cos)]

Pressure, gap, approach and moment follow by integrating h'' over the contact. The parabola, flat
and rounded, compound, wedges with a rounded tip and tables, whose sides may be unequal, are such
profiles.

# notation: eps difference of the bulk strains; eta normal load, I(eta) contact interval of load eta
#           and tilt alpha_0 + kappa eta, m its centre, c its half-length, t = x - m; M(eta) memory
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
of bulk strain leans it as the increment kappa dP of tilt leans p. So q stays a sum of the same
increments that p is a sum of. No source is known for this family; kappa = 0 is the theorem of
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
from numpy.typing import ArrayLike

from scenes import InputError, NotFoundError, ProfileDataError
from scenes.array_types import Array
from scenes.chebyshev import Pieces, Unresolved, halved
from semi_analytic.quadrature import ROOTS, LogisticRule, crowded_nodes, gauss, graded, panel_nodes

# Steps of Newton's method, kept in a bracket: about ten are taken, sixty halvings would do.
_STEPS = 120
# Angle below which sin - theta cos = sum 2 k (-1)^(k + 1) theta^(2 k + 1)/(2 k + 1)! and theta -
# sin cos are summed as series.
_SMALL = 0.3
_K = np.arange(1.0, 9.0)
_FACTORIAL = np.array([float(math.factorial(2 * k + 1)) for k in range(1, 9)])
_OF_MEAN = -((-1.0) ** _K) * 2 * _K / _FACTORIAL
_OF_LOAD = -((-1.0) ** _K) * 4**_K / _FACTORIAL
# Relative error of m and c by their series, measured against the equations themselves.
_NOISE = 1e-12
# Values of knots that are held at a time.
_VALUES = 100_000
# Share of c^2 below which a difference of squares is taken from the rise of the load.
_NEXT = 0.1
# Share of P up to which the kernel of W is a quadrature; above, a difference of closed forms.
_APART = 0.03


class Balance(NamedTuple):
    """Of contacts: mean of h' over sqrt(c^2 - t^2), A P, int h'' d theta and int h'' cos(theta) d
    theta.
    """

    mean_slope: Array
    load: Array
    bend_sum: Array
    bend_cosine_sum: Array


class Angles(NamedTuple):
    """Of the knots over contacts of any shape, with a new last axis: theta, its sine and cosine."""

    theta: Array
    sine: Array
    cosine: Array


class ConvexProfile(abc.ABC):
    """A profile that bends down nowhere, and its contact under any load and tilt.

    Attributes
    ----------
    knots
        (n,) ascending: where h'' is not smooth [length]
    size
        a length about which its contacts may be [length]
    extent
        ends of the profile [length]
    noise
        relative error of h', which that of m and c follows
    """

    knots: Array
    size: float
    extent: tuple[float, float]
    noise: float = _NOISE
    radius: float | None = None
    """Of the parabola about x = 0 that it is; None of others."""

    @abc.abstractmethod
    def touch(self, tilt: ArrayLike) -> Array:
        """Where h' + alpha = 0: the middle of that place, infinite if there is none [length]."""

    @property
    @abc.abstractmethod
    def breaks(self) -> Array:
        """Knots at which h'' bends: an end of contact that meets one is no smooth function of the
        load.
        """

    @abc.abstractmethod
    def balance(self, m: Array, c: Array) -> Balance:
        """What a contact carries."""

    @property
    @abc.abstractmethod
    def _width(self) -> int:
        """Values that are held for each point of a contact."""

    @abc.abstractmethod
    def _pressure(self, x: Array, m: Array, c: Array) -> Array: ...

    @abc.abstractmethod
    def _gap(self, x: Array, m: Array, c: Array) -> Array: ...

    def pressure(self, x: Array, m: Array, c: Array) -> Array:
        """pi A p(x) over a contact; 0 outside. Arrays that broadcast."""
        return self._in_parts(self._pressure, x, m, c)

    def gap(self, x: Array, m: Array, c: Array) -> Array:
        """Gap outside a contact; 0 inside. Arrays that broadcast."""
        return self._in_parts(self._gap, x, m, c)

    @abc.abstractmethod
    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Normal approach of x = 0 less (A P/pi) ln(2 L/c)."""

    @abc.abstractmethod
    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """A times the moment, the integral of x p, of contacts of centre m and half-length c under
        a tilt, arrays of one shape; A = 2/E*.
        """

    def _in_parts(
        self, function: Callable[[Array, Array, Array], Array], *arguments: Array
    ) -> Array:
        """Values of `function` of arrays that broadcast, computed for a block of rows of the first
        axis at a time.

        Each value needs a whole row of knots or quadrature nodes; all of them at once would not fit
        into memory.
        """
        shape = np.broadcast_shapes(*(np.shape(argument) for argument in arguments))
        arrays = []
        for argument in arguments:
            new_axes = (1,) * (len(shape) - np.ndim(argument))
            arrays.append(np.reshape(argument, new_axes + np.shape(argument)))
        if not shape:
            return np.array(function(*arrays))
        rows_at_once = max(_VALUES // max(self._width * math.prod(shape[1:]), 1), 1)
        values = np.empty(shape)
        for first_row in range(0, shape[0], rows_at_once):
            rows = slice(first_row, first_row + rows_at_once)
            array_rows = [array[rows] if len(array) > 1 else array for array in arrays]
            values[rows] = function(*array_rows)
        return values

    def contact(self, load_product: ArrayLike, tilt: ArrayLike) -> tuple[Array, Array]:
        """Centre m and half-length c of the contact under a load and a tilt, arrays that broadcast
        [length].

        They minimise int h d theta + pi alpha m - A P ln(c), with x = m + c cos(theta); alpha is
        the tilt, A = 2/E*. `load_product` is A P. Where P = 0, m is where the profile touches
        first, and c is 0.

        Raises
        ------
        InputError
            For a tilt steeper than the sides, and for a contact that reaches beyond the profile.
        """
        load_product, tilt = np.broadcast_arrays(
            np.asarray(load_product, dtype=float), np.asarray(tilt, dtype=float)
        )
        centre = np.array(self.touch(tilt))
        half_width = np.zeros(load_product.shape)
        if not np.all(np.isfinite(centre)):
            raise InputError(
                "load: the tilt is steeper than the sides of the profile: it touches nowhere along"
                " its sides"
            )
        is_pressed = load_product > 0
        centre[is_pressed], half_width[is_pressed] = self._pressed(
            load_product[is_pressed], tilt[is_pressed], centre[is_pressed]
        )
        left_edge = float(np.min(centre - half_width, initial=0.0))
        right_edge = float(np.max(centre + half_width, initial=0.0))
        left_end, right_end = self.extent
        if left_edge < left_end * (1 + _NOISE) or right_edge > right_end * (1 + _NOISE):
            raise ProfileDataError(
                f"profile: the load needs a contact from {left_edge:.6g} to {right_edge:.6g}, the"
                f" profile goes from {left_end:.6g} to {right_end:.6g}"
            )
        return centre, half_width

    def _pressed(self, load_product: Array, tilt: Array, first_touch: Array) -> tuple[Array, Array]:
        """Centre m and half-length c of the contacts under positive loads and tilts, (n,) each, by
        Newton's method.

        Two equations hold: the mean slope balances the tilt, and the curvature carries the load.
        They are the slopes of a convex sum; a step is halved where it would overshoot the minimum
        of that sum. m and c are those of the last step accepted. The next trial moves the centre by
        `shift` and the half-length by `widening`.

        Parameters
        ----------
        load_product
            (n,) A P, A = 2/E* [length]
        tilt
            (n,) [rad]
        first_touch
            (n,) where the profile touches without load [length]
        """
        # From a wider contact: what either end carries is nearly a convex function of it, and
        # hardly one of the other.
        leftmost = first_touch - self.size
        rightmost = first_touch + self.size
        if len(self.knots):
            leftmost = np.minimum(leftmost, self.knots[0] - self.size)
            rightmost = np.maximum(rightmost, self.knots[-1] + self.size)
        m = (leftmost + rightmost) / 2
        c = (rightmost - leftmost) / 2
        shift = 0 * first_touch
        widening = 0 * first_touch
        predicted_fall = np.full(first_touch.shape, np.inf)
        for _ in range(_STEPS):
            trial_m = m + shift
            trial_c = c + widening
            balance = self.balance(trial_m, trial_c)
            slope_residual = np.pi * (balance.mean_slope + tilt)
            load_residual = (load_product - balance.load) / trial_c
            # A step beyond which the sum would rise half as steeply as it fell before is halved.
            is_accepted = slope_residual * shift - load_residual * widening <= predicted_fall / 2
            m = np.where(is_accepted, trial_m, m)
            c = np.where(is_accepted, trial_c, c)
            newton_shift, newton_widening = _newton_step(
                balance, slope_residual, load_residual, trial_c, c
            )
            # Neither end moves by more than c, nor past what touches first.
            left_move = np.clip(
                newton_shift - newton_widening, -c, 0.9 * np.maximum(first_touch - m + c, 0.0)
            )
            right_move = np.clip(
                newton_shift + newton_widening, 0.9 * np.minimum(first_touch - m - c, 0.0), c
            )
            shift = np.where(is_accepted, (left_move + right_move) / 2, shift / 2)
            widening = np.where(is_accepted, (right_move - left_move) / 2, widening / 2)
            predicted_fall = np.where(
                is_accepted,
                np.abs(slope_residual * shift - load_residual * widening),
                predicted_fall,
            )
            # The next step would be about the power 3/2 of this one.
            largest_step = np.maximum(np.abs(shift), np.abs(widening))
            if np.all(largest_step <= 1e-10 * c + 1e-14 * np.abs(m)):
                return m + shift, c + widening
        raise InputError("profile: its sides do not rise enough to carry the load under this tilt")


def _newton_step(
    balance: Balance,
    slope_residual: Array,
    load_residual: Array,
    half_width: Array,
    fallback_widening: Array,
) -> tuple[Array, Array]:
    """Newton steps of the centre and of the half-length of contacts, (n,) each [length], from the
    residuals of the balance of slope and of load.

    Where the sum that is least at the solution is not convex, the centre stays and the contact
    widens by `fallback_widening`.

    Parameters
    ----------
    balance
        integrals of h'' over each contact, of which the Jacobian is made
    slope_residual, load_residual
        (n,) error of the mean slope times pi, and of the load over the half-length
    half_width
        (n,) half-lengths before the step
    """
    bend_sum = balance.bend_sum
    bend_cosine_sum = balance.bend_cosine_sum
    off_diagonal_with_residual = bend_cosine_sum + slope_residual / half_width
    # The full matrix only where its determinant is positive, with a margin.
    is_safely_convex = bend_sum * bend_sum > 1.1 * off_diagonal_with_residual * bend_cosine_sum
    off_diagonal = np.where(is_safely_convex, off_diagonal_with_residual, bend_cosine_sum)
    determinant = bend_sum * bend_sum - off_diagonal * bend_cosine_sum
    is_convex = determinant > 0
    determinant = np.where(is_convex, determinant, 1.0)
    shift = -(slope_residual * bend_sum + off_diagonal * load_residual) / determinant
    widening = (bend_sum * load_residual + slope_residual * bend_cosine_sum) / determinant
    return np.where(is_convex, shift, 0.0), np.where(is_convex, widening, fallback_widening)


@dataclass(frozen=True, eq=False)
class PiecewiseParabola(ConvexProfile):
    """A profile whose h'' is constant between knots.

    Attributes
    ----------
    knots, curvature
        (n,) ascending [length], (n + 1,) of the pieces between and beyond [1/length]
    slope, height
        h' and h at the first knot
    extent
        ends of the profile [length]
    """

    knots: Array
    curvature: Array
    slope: float
    height: float
    extent: tuple[float, float] = (-np.inf, np.inf)

    @property
    def size(self) -> float:  # type: ignore[override]
        return float(np.ptp(self.knots)) + 1e-3 / float(np.max(self.curvature))

    @cached_property
    def jumps(self) -> Array:
        """J."""
        return np.diff(self.curvature)

    @property
    def breaks(self) -> Array:
        return self.knots[self.jumps != 0]

    @cached_property
    def radius(self) -> float | None:  # type: ignore[override]
        if not self.is_parabola or self.touch(0.0) != 0:
            return None
        return 1 / float(self.curvature[0])

    @cached_property
    def is_parabola(self) -> bool:
        """Whether h'' is the same everywhere: of such a profile m and c have closed forms."""
        return bool(np.all(self.jumps == 0))

    def angles(self, m: Array, c: Array) -> Angles:
        """Of the knots over contacts of centre m and half-length c; 0 beyond the right end, pi
        beyond the left one.
        """
        distance = self.knots - m[..., None]
        half_width = np.asarray(c)[..., None]
        ratio = np.where(
            half_width > 0, distance / np.where(half_width > 0, half_width, 1.0), np.sign(distance)
        )
        cosine = np.clip(ratio, -1.0, 1.0)
        return Angles(np.arccos(cosine), np.sqrt((1 - cosine) * (1 + cosine)), cosine)

    @cached_property
    def slopes(self) -> Array:
        """h' at the knots."""
        rises = np.cumsum(self.curvature[1:-1] * np.diff(self.knots))
        return np.concatenate([[self.slope], self.slope + rises])

    def touch(self, tilt: ArrayLike) -> Array:
        """Where the tilted profile touches without load, h' + alpha = 0: the middle of that place
        [length], infinite where there is none.

        h' is linear between knots, so that the place is found between the two knots around it; a
        straight part of that slope touches all along.
        """
        slope = -np.asarray(tilt, dtype=float)
        last_knot = len(self.knots) - 1
        first_knot_at_slope = np.searchsorted(self.slopes, slope, "left")
        first_knot_beyond = np.searchsorted(self.slopes, slope, "right")
        knot_before = np.clip(first_knot_at_slope - 1, 0, last_knot)
        curvature = self.curvature[first_knot_at_slope]
        slope_rise = slope - self.slopes[knot_before]
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = np.where(
                curvature > 0, slope_rise / curvature, np.copysign(np.inf, slope_rise)
            )
            between_knots = self.knots[knot_before] + distance
        left_end_of_touch = self.knots[np.minimum(first_knot_at_slope, last_knot)]
        right_end_of_touch = self.knots[np.maximum(first_knot_beyond - 1, 0)]
        return np.where(
            first_knot_beyond > first_knot_at_slope,
            (left_end_of_touch + right_end_of_touch) / 2,
            between_knots,
        )

    def balance(self, m: Array, c: Array) -> Balance:
        """Mean slope, load and curvature integrals of contacts of centre m and half-length c, in
        closed form: sums over the knots of the jumps J of h''.

            mean slope = h'(m) + (c/pi) sum J (sin(theta) - theta cos(theta))
            A P        = (c^2/2) [pi h''(m) + sum +-J (theta - sin(theta) cos(theta))]

        theta is the angle of a knot at m +- c cos(theta). Knots are counted from m outwards, so
        that an end next to a knot keeps its digits.
        """
        piece_at_middle = np.searchsorted(self.knots, m)
        knot_before = np.maximum(piece_at_middle - 1, 0)
        curvature = self.curvature[piece_at_middle]
        distance = self.knots - m[..., None]
        half_width = np.where(c > 0, c, 1.0)[..., None]
        depth = np.clip(1 - np.abs(distance) / half_width, 0.0, 1.0)
        theta = 2 * np.arcsin(np.sqrt(depth / 2))
        sine = np.sqrt(depth * (2 - depth))
        side = np.where(distance >= 0, 1.0, -1.0)
        mean_functions, load_functions = _angle_functions(theta, sine, 1 - depth)
        slope_at_middle = self.slopes[knot_before] + curvature * (m - self.knots[knot_before])
        return Balance(
            mean_slope=c * (mean_functions @ self.jumps) / np.pi + slope_at_middle,
            load=c * c / 2 * (np.pi * curvature + (side * load_functions) @ self.jumps),
            bend_sum=np.pi * curvature + (side * theta) @ self.jumps,
            bend_cosine_sum=sine @ self.jumps,
        )

    def contact(self, product: ArrayLike, tilt: ArrayLike) -> tuple[Array, Array]:
        if not self.is_parabola:
            return super().contact(product, tilt)
        curvature = self.curvature[0]
        product, tilt = np.broadcast_arrays(
            np.asarray(product, dtype=float), np.asarray(tilt, dtype=float)
        )
        middle = self.knots[0] - (self.slope + tilt) / curvature
        half_width = np.sqrt(2 * np.maximum(product, 0.0) / (np.pi * curvature))
        return middle, half_width

    # --- what follows from a contact

    @property
    def _width(self) -> int:
        return len(self.knots)

    def _pressure(self, x: Array, m: Array, c: Array) -> Array:
        """Contact pressure times pi A at x, A = 2/E*, for contacts of centre m and half-length c,
        arrays that broadcast [1]; 0 outside.

            pi A p = pi h''_0 r + sum over knots of J [r theta_b - (b - x) ln|...|],
            r = sqrt(c^2 - (x - m)^2)

        h''_0 is the curvature left of all knots, J its jump at a knot b = m + c cos(theta_b). The
        logarithm is of sin((theta_x + theta_b)/2)/sin((theta_x - theta_b)/2).
        """
        t = x - m
        if self.is_parabola:
            squared_root = np.maximum((c - x + m) * (c + x - m), 0.0)
            return np.asarray(np.pi * self.curvature[0] * np.sqrt(squared_root))
        knot_angles = self.angles(m, c)
        root = np.sqrt(np.maximum((c - t) * (c + t), 0.0))[..., None]
        half_width = np.where(c > 0, c, 1.0)[..., None]
        distance_to_knot = self.knots - x[..., None]
        # ln|sin((theta_x + theta)/2)/sin((theta_x - theta)/2)|, each sine times the same factor
        sine_of_point = root / half_width * (1 + knot_angles.cosine)
        sine_of_knot = knot_angles.sine * (1 + t[..., None] / half_width)
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log(
                np.abs((sine_of_point + sine_of_knot) / (sine_of_point - sine_of_knot))
            )
        is_zero = (distance_to_knot == 0) | (knot_angles.sine == 0) | ~np.isfinite(logarithm)
        logarithm = np.where(is_zero, 0.0, logarithm)
        terms_of_knots = root * knot_angles.theta - distance_to_knot * logarithm
        pressure = terms_of_knots @ self.jumps + np.pi * self.curvature[0] * root[..., 0]
        return np.where(root[..., 0] > 0, pressure, 0.0)

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        """Gap at x outside contacts of centre m and half-length c, arrays that broadcast [length];
        0 inside.

        With F = d r - c^2 u, r = sqrt(d^2 - c^2), it is h''_0 F/2 plus for each knot b = m + c
        cos(theta) the jump J of h'' there times

            (x - b)_+^2/2 + [theta F - (x - b)^2 phi - s c sin(theta) (r - s c cos(theta) u)]/(2 pi)

        # notation: t = x - m, d = |t|, s sign of t, u = arccosh(d/c), h''_0 curvature left of all
        #           knots; tan(phi/2) = tan(theta/2) over tanh(u/2) where s > 0, else times it
        """
        t = x - m
        theta, sine, cosine = self.angles(m, c)
        distance = np.maximum(np.abs(t), c)
        r = np.sqrt((distance - c) * (distance + c))
        u = np.where(c > 0, np.arcsinh(r / np.where(c > 0, c, 1.0)), 0.0)
        parabola_term = distance * r - c * c * u
        side = np.sign(t)[..., None]
        # phi by opposite over adjacent leg of its half
        zeros = np.zeros(t.shape)
        leg_ratio = np.divide(r, distance + c, out=zeros, where=distance + c > 0)[..., None]
        opposite_leg = np.where(side > 0, sine, leg_ratio * sine)
        adjacent_leg = np.where(side > 0, leg_ratio, 1.0) * (1 + cosine)
        phi = 2 * np.arctan2(opposite_leg, adjacent_leg)
        phi = np.where(cosine >= 1, 0.0, phi)
        phi = np.where(cosine <= -1, np.pi, phi)
        from_knot = x[..., None] - self.knots
        knot_height = c[..., None] * sine
        knot_distance = c[..., None] * cosine
        terms_of_knots = np.square(np.maximum(from_knot, 0.0)) / 2
        terms_of_knots = terms_of_knots - from_knot * from_knot * phi / (2 * np.pi)
        lever = r[..., None] - side * knot_distance * u[..., None]
        terms_of_knots += (theta * parabola_term[..., None] - side * knot_height * lever) / (
            2 * np.pi
        )
        gap = terms_of_knots @ self.jumps + self.curvature[0] / 2 * parabola_term
        return np.where(np.abs(t) > c, gap, 0.0)

    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Normal approach of the point x = 0 of contacts of centre m and half-length c under a
        tilt, without its term (A P/pi) ln(2 L/c) [length]; A = 2/E*, L the distance of the datum.

        It is the mean of h + alpha x over the contact by angle, x = m + c cos(theta).
        """
        theta, sine, cosine = self.angles(m, c)
        from_first_knot = m - self.knots[0]
        to_knot = self.knots - m[..., None]
        angle_terms = theta / 2 - 1.5 * sine * cosine
        sum_over_knots = (
            theta * to_knot * to_knot + np.square(c)[..., None] * angle_terms
        ) @ self.jumps
        mean_square = from_first_knot * from_first_knot + c * c / 2
        part_of_parabola = (
            self.height + self.slope * from_first_knot + self.curvature[0] / 2 * mean_square
        )
        return np.asarray(part_of_parabola + np.asarray(tilt) * m + sum_over_knots / (2 * np.pi))

    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        """Moment of the pressure, A int x p dx, of contacts of centre m and half-length c under a
        tilt; A = 2/E* [length^2].

        It is m times A P, plus what the tilt and the jumps of h'' at the knots make about the
        centre.
        """
        theta, sine, cosine = self.angles(m, c)
        half_width = c[..., None]
        to_knot = self.knots - m[..., None]
        angle_terms = sine - sine**3 / 3 - sine * cosine * cosine / 2
        sum_over_knots = (half_width * angle_terms - theta * to_knot / 2) @ self.jumps
        slope_at_middle = np.asarray(tilt) + self.slope + self.curvature[0] * (m - self.knots[0])
        return np.asarray(
            m * self.balance(m, c).load + c * c * (sum_over_knots + np.pi / 2 * slope_at_middle)
        )


def _angle_functions(theta: Array, sine: Array, cosine: Array) -> tuple[Array, Array]:
    """sin(theta) - theta cos(theta) and theta - sin(theta) cos(theta): what a jump of curvature at
    angle theta adds to the mean slope and to the load of a contact.

    Small angles take series, since the differences would lose digits.
    """
    mean_function = sine - theta * cosine
    load_function = theta - sine * cosine
    is_small = theta < _SMALL
    if np.any(is_small):
        squared_angle = np.square(theta)
        cubed_angle = theta * squared_angle
        mean_series = cubed_angle * np.polynomial.polynomial.polyval(squared_angle, _OF_MEAN)
        load_series = cubed_angle * np.polynomial.polynomial.polyval(squared_angle, _OF_LOAD)
        mean_function = np.where(is_small, mean_series, mean_function)
        load_function = np.where(is_small, load_series, load_function)
    return mean_function, load_function


# Share of c, or of the distance to a knot, within which h'' stands for a difference quotient of h'.
_NEAR = 1e-5


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
    height, gradient, bend
        h, h' and h''
    rule
        on a part between knots; `ROOTS` for singular ends
    exponent
        n of |x|^n near the knot x = 0
    noise
        relative error of h'
    """

    knots: Array
    size: float
    height: Callable[[Array], Array]
    gradient: Callable[[Array], Array]
    bend: Callable[[Array], Array]
    rule: LogisticRule = ROOTS
    exponent: float = 2.0
    extent: tuple[float, float] = (-np.inf, np.inf)
    noise: float = _NOISE

    @property
    def breaks(self) -> Array:
        return self.knots

    def touch(self, tilt: ArrayLike) -> Array:
        """Where the tilted profile touches without load, h' + alpha = 0: the middle of that place
        [length], infinite where there is none.

        h' rises everywhere. The first and the last place of that slope are found by halving an
        interval about the origin, doubled until it holds them.
        """
        target_slope = -np.asarray(tilt, dtype=float)
        half_interval = self.size
        steepest = np.max(np.abs(target_slope))
        while self.gradient(np.array(half_interval)) < steepest and half_interval < 1e9 * self.size:
            half_interval = 2 * half_interval
        left_bound, _ = self._halved(target_slope, half_interval, np.greater_equal)
        _, right_bound = self._halved(target_slope, half_interval, np.greater)
        is_reached = np.abs(target_slope) <= self.gradient(np.array(half_interval))
        return np.where(is_reached, (left_bound + right_bound) / 2, np.inf)

    def _halved(
        self, target_slope: Array, reach: float, is_above: Callable[[Array, Array], Array]
    ) -> tuple[Array, Array]:
        """Bounds from left and right of the place where the slope h' of the profile passes a
        target, by 64 halvings of the interval +- `reach` [length].

        `is_above` compares slopes of the profile with the targets; the arrays have the shape of
        `target_slope`.
        """
        left_bound = np.full(target_slope.shape, -reach)
        right_bound = np.full(target_slope.shape, reach)
        for _ in range(64):
            middle = (left_bound + right_bound) / 2
            is_beyond = is_above(self.gradient(middle), target_slope)
            left_bound = np.where(is_beyond, left_bound, middle)
            right_bound = np.where(is_beyond, middle, right_bound)
        return left_bound, right_bound

    def _nodes(self, m: Array, c: Array) -> tuple[Array, Array, Array]:
        """Quadrature nodes over contacts of centre m and half-length c: their places xi, distances
        xi - m, and weights of an average, with a new last axis.

        Averages are over equal angles theta, xi = m + c cos(theta). The range of angles is cut at
        the knots of the profile, where h'' is not smooth. A node is placed from the nearer end of
        its part, so that its distance from a knot keeps its digits.
        """
        m, c = np.broadcast_arrays(m, c)
        m = m[..., None]
        c = c[..., None]
        to_knot = self.knots[::-1] - m
        knot_root = np.sqrt(np.maximum((c - to_knot) * (c + to_knot), 0.0))
        knot_theta = np.arctan2(knot_root, to_knot)
        angles_of_ends = np.concatenate([0 * m, knot_theta, 0 * m + np.pi], axis=-1)
        knots_within = np.clip(to_knot + m, m - c, m + c)
        places_of_ends = np.concatenate([m + c, knots_within, m - c], axis=-1)
        angle_spans = np.diff(angles_of_ends)[..., None]
        # From the end next to a node, so that its distance from a knot keeps its digits.
        is_from_begin = self.rule.up < 0.5

        def nearer_end(at_ends: Array) -> Array:
            return np.where(is_from_begin, at_ends[..., :-1, None], at_ends[..., 1:, None])

        angle_from_end = np.where(
            is_from_begin, angle_spans * self.rule.up, -angle_spans * self.rule.down
        )
        half_sine = np.sin(angle_from_end / 2)
        half_cosine = np.sqrt(1 - half_sine * half_sine)
        sine = nearer_end(np.sin(angles_of_ends))
        cosine = nearer_end(np.cos(angles_of_ends))
        distance_from_end = 2 * c[..., None] * half_sine * (sine * half_cosine + cosine * half_sine)
        xi = nearer_end(places_of_ends) - distance_from_end
        weights = angle_spans * self.rule.weight / np.pi
        if len(self.knots):
            # What the rule leaves out of |x|^(n - 2) is a geometric series.
            tail_exponent = (self.exponent - 1) * self.rule.weight[0] / self.rule.up[0]
            factor_of_tail = 1 + 1 / math.expm1(tail_exponent)
            weights[..., 0] *= np.where(places_of_ends[..., :-1] == 0, factor_of_tail, 1.0)
            weights[..., -1] *= np.where(places_of_ends[..., 1:] == 0, factor_of_tail, 1.0)
        shape = (*xi.shape[:-2], xi.shape[-2] * xi.shape[-1])
        return xi.reshape(shape), (xi - m[..., None]).reshape(shape), weights.reshape(shape)

    def balance(self, m: Array, c: Array) -> Balance:
        xi, t, weight = self._nodes(m, c)
        slope = weight * self.gradient(xi)
        bend = np.pi * weight * self.bend(xi)
        cosine = t / np.where(c > 0, c, 1.0)[..., None]
        return Balance(
            mean_slope=np.sum(slope, axis=-1),
            load=np.sum(np.pi * slope * t, axis=-1),
            bend_sum=np.sum(bend, axis=-1),
            bend_cosine_sum=np.sum(bend * cosine, axis=-1),
        )

    @property
    def _width(self) -> int:
        return (len(self.knots) + 1) * len(self.rule.up)

    def _pressure(self, x: Array, m: Array, c: Array) -> Array:
        """Contact pressure times pi A at x, A = 2/E*, for contacts of centre m and half-length c,
        arrays that broadcast [1]; 0 outside.

            pi A p = pi sqrt(c^2 - (x - m)^2) mean of (h'(xi) - h'(x))/(xi - x)

        The mean is over the angle theta of xi = m + c cos(theta). Where xi is close to x the
        quotient is h'' between them.
        """
        xi, _, weights = self._nodes(m, c)
        place_column = np.asarray(x)[..., None]
        root = np.sqrt(np.maximum((c - x + m) * (c + x - m), 0.0))
        distance_to_node = xi - place_column
        distances_to_knots = np.abs(place_column - self.knots)
        distance_to_next_knot = np.min(distances_to_knots, axis=-1, initial=np.inf, keepdims=True)
        is_near = np.nonzero(
            np.abs(distance_to_node) < _NEAR * np.minimum(distance_to_next_knot, c[..., None])
        )
        places_between = (
            (place_column + distance_to_node / 2)[is_near]
            if len(is_near[0])
            else distance_to_node[is_near]
        )
        distance_to_node[is_near] = np.inf
        slope_rise = self.gradient(xi) - self.gradient(place_column)
        quotient = slope_rise / np.where(distance_to_node == 0, np.inf, distance_to_node)
        quotient[is_near] = self.bend(places_between)
        return np.asarray(np.pi * root * np.sum(weights * quotient, axis=-1))

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        """Gap at x outside contacts of centre m and half-length c, arrays that broadcast [length];
        0 inside.

            gap = mean of +-c sinh(u) [(h(x) - h(xi))/(x - xi) - h'(xi)] - u (xi - m) h'(xi)

        The mean is over the angle theta of xi = m + c cos(theta); x = m +- c cosh(u).
        """
        nodes, distance_from_middle, weights = self._nodes(m, c)
        distance = np.maximum(np.abs(x - m), c)
        root = np.sqrt((distance - c) * (distance + c))
        u = np.where(c > 0, np.arcsinh(root / np.where(c > 0, c, 1.0)), 0.0)
        places = np.asarray(x)[..., None]
        distance_to_node = places - nodes
        slope = self.gradient(nodes)
        height_rise = self.height(places) - self.height(nodes)
        chord = np.divide(
            height_rise,
            distance_to_node,
            out=np.zeros(distance_to_node.shape),
            where=distance_to_node != 0,
        )
        signed_root = (np.sign(x - m) * root)[..., None]
        values_at_nodes = (
            signed_root * (chord - slope) - u[..., None] * distance_from_middle * slope
        )
        return np.asarray(np.sum(weights * values_at_nodes, axis=-1))

    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        xi, _, weight = self._nodes(m, c)
        return np.asarray(np.sum(weight * self.height(xi), axis=-1) + np.asarray(tilt) * m)

    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        del tilt
        xi, t, weight = self._nodes(m, c)
        lever = m[..., None] * t + t * t - c[..., None] ** 2 / 2
        return np.asarray(np.pi * np.sum(weight * self.gradient(xi) * lever, axis=-1))


@dataclass(frozen=True, eq=False)
class NestedIntervals:
    """Contacts I(eta) of a convex profile under the loads eta and the tilts alpha_0 + kappa eta, by
    series.

    m and c are series of the root of eta - eta_b behind each load eta_b at which an end meets a
    knot.

    Attributes
    ----------
    shape, compliance
        the profile, A
    tilt_without_load, tilt_per_load
        alpha_0 and kappa [1/force per thickness]
    largest_load
        the largest load that is asked for
    """

    shape: ConvexProfile
    compliance: float
    tilt_without_load: float
    tilt_per_load: float
    largest_load: float

    def exactly(self, load: ArrayLike) -> tuple[Array, Array]:
        """m and c of I(eta) from the equations themselves."""
        eta = np.asarray(load, dtype=float)
        return self.shape.contact(
            self.compliance * eta, self.tilt_without_load + self.tilt_per_load * eta
        )

    @cached_property
    def scale(self) -> float:
        """The largest half-length."""
        return float(self.exactly(self.largest_load)[1])

    @cached_property
    def start(self) -> tuple[Array, Array]:
        """m and c of no load."""
        return self.exactly(0.0)

    @cached_property
    def face(self) -> tuple[float, float]:
        """Middle and half-length of a flat face that touches under no load."""
        middle = float(self.start[0])
        if self.shape.radius is not None:
            return middle, 0.0
        return middle, float(self._series.half(0.0))

    @cached_property
    def break_loads(self) -> Array:
        """Loads at which an end of I(eta) is at a knot, ascending."""
        loads = self.load(self.shape.breaks)
        return np.unique(loads[np.isfinite(loads) & (loads > 1e-12 * self.largest_load)])

    @cached_property
    def _series(self) -> _IntervalSeries:
        """Chebyshev series of centre and half-length of the contact over the load, from 0 to the
        largest.

        The load is cut where an end of the contact meets a knot of the profile. Behind each cut
        both are smooth in the root of the load since then; these roots are laid side by side on one
        axis.
        """
        breaks = self.break_loads[self.break_loads < self.largest_load * (1 - 1e-9)]
        loads_of_cuts = np.concatenate([[0.0], breaks, [self.largest_load]])
        ends_on_axis = np.concatenate([[0.0], np.cumsum(np.sqrt(np.diff(loads_of_cuts)))])
        middle_series = []
        half_width_series = []
        for begin_load, end_load in pairwise(loads_of_cuts.tolist()):
            middle_between_cuts, half_width_between_cuts = self._series_between(
                begin_load, end_load
            )
            middle_series.append(middle_between_cuts)
            half_width_series.append(half_width_between_cuts)
        return _IntervalSeries(
            loads_of_cuts[:-1],
            ends_on_axis,
            _side_by_side(middle_series, ends_on_axis),
            _side_by_side(half_width_series, ends_on_axis),
        )

    def _series_between(self, lower_load: float, upper_load: float) -> tuple[Pieces, Pieces]:
        """Chebyshev series of centre and half-length of the contact over v = sqrt(eta -
        lower_load), for loads eta between two at which an end of the contact meets a knot of the
        profile.

        Raises
        ------
        NotFoundError
            Where no series resolves them.
        """
        ends = np.array([0.0, math.sqrt(upper_load - lower_load)])
        # Over 4e-15: beside a flat the last digits of a contact are noise.
        floor = 0.1 * self.shape.noise / 4e-15 * self.scale
        try:
            return (
                halved(lambda v: self.exactly(lower_load + v * v)[0], ends, floor),
                halved(lambda v: self.exactly(lower_load + v * v)[1], ends, floor),
            )
        except Unresolved as fault:
            raise NotFoundError(
                f"no contact was found under the tilt {self.tilt_without_load:.6g} and loads of"
                f" about {lower_load:.6g}"
            ) from fault

    def at(self, load: ArrayLike) -> tuple[Array, Array]:
        """m and c of I(eta)."""
        if self.shape.radius is not None:
            return self.exactly(load)
        eta = np.clip(np.asarray(load, dtype=float), 0.0, self.largest_load)
        series = self._series
        series_number = np.searchsorted(series.begin_loads, eta, side="right") - 1
        root = np.sqrt(eta - series.begin_loads[series_number])
        place = np.minimum(series.places[series_number] + root, series.places[series_number + 1])
        half_width = np.maximum(series.half(place), 0.0)
        return series.middle(place), np.where(eta > 0, half_width, 0.0)

    def growth(self, side: Array, load: Array, load_rise: Array) -> Array:
        """How far one end of the contact has moved outwards while the load rose by `load_rise` to
        `load`, (n,) [length].

        It is the integral of the end's rate over the load. The difference of two ends next to each
        other would be mere error of their series. `side` is +1 for the right end, -1 for the left
        one.
        """
        radius = self.shape.radius
        if radius is not None:  # of a parabola in closed form
            _, half_after = self.exactly(load)
            _, half_before = self.exactly(load - load_rise)
            widening = 2 * self.compliance * radius / np.pi / (half_after + half_before)
            return load_rise * (widening - side * radius * self.tilt_per_load)
        series = self._series
        series_number = np.searchsorted(series.begin_loads, load, side="right") - 1
        outward_growth = np.zeros(load.shape)
        nodes, weights_of_nodes = gauss(8)
        rise_left = load_rise
        outer_root = np.sqrt(load - series.begin_loads[series_number])
        while np.any(series_number >= 0):
            rise_on_series = np.minimum(rise_left, outer_root * outer_root)
            inner_root = np.sqrt(outer_root * outer_root - rise_on_series)
            root_step = rise_on_series / np.maximum(outer_root + inner_root, 1e-300)
            begin_place = series.places[series_number][:, None]
            end_place = np.nextafter(series.places[series_number + 1], 0.0)[:, None]
            place_on_axis = np.clip(
                begin_place + (outer_root[:, None] - root_step[:, None] * nodes),
                begin_place,
                end_place,
            )
            rate = series.half.derivative(place_on_axis) + side[:, None] * series.middle.derivative(
                place_on_axis
            )
            outward_growth += root_step * np.sum(weights_of_nodes * rate, axis=1)
            series_number = np.where(rise_left > rise_on_series, series_number - 1, -1)
            rise_left = rise_left - rise_on_series
            outer_root = series.places[series_number + 1] - series.places[series_number]
        return outward_growth

    def load(self, x: Array) -> Array:
        """The load P at which the contact first reaches x as one of its ends [force per thickness];
        infinite where none up to the largest does.

        x is an end where the mean of h' over the contact is -(alpha_0 + kappa P), the tilt under P.
        With x fixed, that mean falls as the half-length c grows: Newton's method for c, kept in a
        bracket.
        """
        middle, half_width = self.exactly(self.largest_load)
        is_reached = np.abs(x - middle) <= half_width * (1 + 1e-8)
        reached_x = x[is_reached]
        tilt_over_compliance = self.tilt_per_load / self.compliance
        side = np.where(reached_x < float(self.shape.touch(self.tilt_without_load)), -1.0, 1.0)
        least_c = np.zeros(reached_x.shape)
        largest_c = np.full(reached_x.shape, 2.1 * self.scale)
        c = largest_c / 2
        for _ in range(_STEPS):
            balance = self.shape.balance(reached_x - side * c, c)
            slope_excess = side * (balance.mean_slope + self.tilt_without_load)
            slope_excess = slope_excess + side * tilt_over_compliance * balance.load
            fall_rate = (balance.bend_sum - side * balance.bend_cosine_sum) * (
                1 / np.pi - side * tilt_over_compliance * c
            )
            least_c = np.where(slope_excess > 0, c, least_c)
            largest_c = np.where(slope_excess > 0, largest_c, c)
            newton_c = c + slope_excess / np.where(fall_rate > 0, fall_rate, np.inf)
            is_in_bracket = (fall_rate > 0) & (newton_c >= least_c) & (newton_c <= largest_c)
            new_c = np.where(is_in_bracket, newton_c, (least_c + largest_c) / 2)
            is_small_step = is_in_bracket & (np.abs(new_c - c) <= 1e-10 * c)
            is_done = is_small_step | (largest_c - least_c <= 4e-16 * self.scale)
            c = new_c
            if np.all(is_done):
                break
        loads = np.full(x.shape, np.inf)
        loads[is_reached] = self.shape.balance(reached_x - side * c, c).load / self.compliance
        return np.where(loads <= self.largest_load * (1 + 1e-9), loads, np.inf)


class _IntervalSeries(NamedTuple):
    """m and c over one axis, on which stretches of v = sqrt(eta - eta_b) lie side by side: the load
    at which each begins (k,), the places of their ends (k + 1,).
    """

    begin_loads: Array
    places: Array
    middle: Pieces
    half: Pieces


def _side_by_side(series: list[Pieces], places: Array) -> Pieces:
    """Series on one axis, each from its place on."""
    edges = [np.zeros(1)]
    for pieces, place in zip(series, places[:-1], strict=True):
        edges.append(pieces.edges[1:] + place)
    coefficients = np.concatenate([pieces.coefficients for pieces in series], axis=1)
    return Pieces(np.concatenate(edges), coefficients)


@dataclass(frozen=True, eq=False)
class TiltedProfile:
    """A convex profile under the tilt alpha_0 + kappa eta. Arrays broadcast; points x carry their
    sign.

    Attributes
    ----------
    intervals
        I(eta)
    datum_length
        L, distance of the datum of rigid movements [length]
    rigid
        what `log_ratio` and its integrals are over A/pi: the rate of U, of U + kappa m_q
        ("loop"), or mu itself ("moment")
    """

    intervals: NestedIntervals
    datum_length: float
    rigid: Literal["displacement", "loop", "moment"] = "displacement"
    bends_anywhere: ClassVar[bool] = False
    breaks: ClassVar[tuple[float, ...]] = ()
    least_half_width: ClassVar[float] = 0.0
    tangential_fraction: ClassVar[float] = 1.0
    """Rise of Q over that of the load in whose terms the memory curve is: 1, or 0 where bulk strain
    alone changes.
    """

    @property
    def closed_form(self) -> bool:
        """Whether contacts are known without series."""
        return self.shape.radius is not None

    @property
    def noise(self) -> float:
        """Relative error of m and c."""
        return self.shape.noise

    @property
    def shape(self) -> ConvexProfile:
        """The profile."""
        return self.intervals.shape

    @property
    def _compliance(self) -> float:
        """A."""
        return self.intervals.compliance

    @cached_property
    def lean(self) -> float:
        """pi kappa/A."""
        return float(np.pi * self.intervals.tilt_per_load / self._compliance)

    def at(self, load: ArrayLike) -> tuple[Array, Array]:
        """m and c of I(eta)."""
        return self.intervals.at(load)

    @property
    def break_loads(self) -> Array:
        """Loads at which an end of I(eta) is at a knot, ascending."""
        return self.intervals.break_loads

    def is_nested(self, load: float) -> bool:
        """Whether every I(eta) up to a load holds all that come before it: whether dp/d eta > 0 in
        it, |kappa| <= A/(pi c).
        """
        return bool(abs(self.lean) * self.half_width(load) <= 1 + 1e-11)

    def centre(self, load: ArrayLike) -> Array:
        """m(eta) [length]."""
        return self.at(load)[0]

    def half_width(self, load: ArrayLike) -> Array:
        """c(eta) [length]."""
        return self.at(load)[1]

    def interval(self, load: ArrayLike) -> Array:
        """Ends of I(eta) [length], a new last axis."""
        m, c = self.at(load)
        return np.stack([m - c, m + c], axis=-1)

    def advance(self, load: ArrayLike) -> Array:
        """What kernels know an interval by: its load."""
        return np.asarray(load, dtype=float)

    load_at = advance

    def load(self, half_width: ArrayLike) -> Array:
        """P_x: the load at which x is an end of I(eta) [force per thickness]; infinite where none
        up to the largest is.
        """
        return self.intervals.load(np.asarray(half_width, dtype=float))

    # --- normal contact under any tilt

    def under(self, load: Array, tilt: Array) -> tuple[Array, Array]:
        """m and c of the contact of loads and tilts (n,)."""
        return self.shape.contact(self._compliance * load, tilt)

    def pressure_over(self, x: Array, m: Array, c: Array) -> Array:
        """p at points (k,) of contacts (n,): (n, k)."""
        pressure = np.maximum(self.shape.pressure(x, m[:, None], c[:, None]), 0.0)
        return np.asarray(pressure / (np.pi * self._compliance))

    def approach(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """Normal approach at x = 0 of contacts (n,) [length]."""
        return self.shape.approach(m, c, tilt) + self._compliance / np.pi * load * self.logarithm(c)

    def moment(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """int x p of contacts (n,) [force]."""
        del load
        return self.shape.moment(m, c, tilt) / self._compliance

    def tilt_under(self, load: Array, moment: Array) -> Array:
        """The tilt at which contacts under loads (n,) carry given moments (n,), moment = int x p
        dx, by Newton's method; 0 where there is no load.

        A larger tilt moves the contact to the left and the moment falls. Steps are kept in a
        bracket.

        Raises
        ------
        InputError
            For a moment that the profile carries at no tilt.
        NotFoundError
            Where the steps do not converge.
        """
        load = np.maximum(load, 0.0)
        moment = np.where(load > 0, moment, 0.0)
        if self.shape.radius is not None:
            return -moment / (self.shape.radius * np.where(load > 0, load, np.inf))

        unlike_pairs, pair_number = np.unique(np.stack([load, moment]), axis=1, return_inverse=True)
        load, moment = unlike_pairs
        least_tilt = np.full(load.shape, -np.inf)
        largest_tilt = np.full(load.shape, np.inf)
        tilt = np.zeros(load.shape)
        for _ in range(_STEPS):
            m, c = self.under(load, tilt)
            excess_moment = self.moment(m, c, load, tilt) - moment
            half_width = np.where(c > 0, c, 1.0)
            least_tilt = np.where(excess_moment > 0, tilt, least_tilt)
            largest_tilt = np.where(excess_moment > 0, largest_tilt, tilt)
            # A change of tilt adds -(d alpha/A) t/sqrt(c^2 - t^2) to p. No step moves a contact by
            # more than about a third of it.
            longest_step = self._compliance * load / (4 * half_width)
            step = 2 * self._compliance * excess_moment / (np.pi * half_width**2)
            new_tilt = tilt + np.clip(step, -longest_step, longest_step)
            is_in_bracket = (new_tilt >= least_tilt) & (new_tilt <= largest_tilt)
            new_tilt = np.where(is_in_bracket, new_tilt, (least_tilt + largest_tilt) / 2)
            change = np.abs(new_tilt - tilt)
            tilt = new_tilt
            if np.all(change <= 1e-9 * longest_step):
                return np.where(load > 0, tilt, 0.0)[pair_number.ravel()]
        raise NotFoundError(
            "load: no tilt was found at which the contact carries the moment that is stated"
        )

    # --- kernels of the family

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        value = self.shape.pressure(np.asarray(x, dtype=float), *self.intervals.at(load))
        return np.asarray(np.maximum(value, 0.0) / (np.pi * self._compliance))

    pressure_rise = pressure

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load]."""
        place, load = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(load, dtype=float))
        eta, weight = self._nodes(np.minimum(self.load(place), load), load)
        integral = np.sum(weight * self.pressure(place[..., None], eta), axis=-1)
        return load * self.pressure(place, load) - integral

    def _nodes(self, begin: Array, end: Array) -> tuple[Array, Array]:
        """Nodes and weights on loads, cut at those at which an end meets a knot, a new last
        axis.
        """
        if not len(self.break_loads):
            return graded(begin, end)
        nodes = panel_nodes(begin, end, self.break_loads)
        shape = (*np.shape(end), -1)
        return nodes.at.reshape(shape), nodes.weight.reshape(shape)

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^eta of the kernel of slip while x is open: pi/A times what its gap closes by [force
        per thickness].
        """
        x = np.asarray(x, dtype=float)
        gap_before = self.shape.gap(x, *self.intervals.start)
        gap_after = self.shape.gap(x, *self.intervals.at(load))
        return np.maximum(gap_before - gap_after, 0.0) * np.pi / self._compliance

    def slip_integral_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """The same with eta in front [force^2 per thickness^2]."""
        x, load = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(load, dtype=float))
        eta, weight = self._nodes(np.zeros(load.shape), np.minimum(load, self.load(x)))
        kernel = self.arccosh_ratio(x[..., None], 0.0, eta)
        return np.asarray(np.sum(weight * eta * kernel, axis=-1))

    def arccosh_ratio(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """The kernel of slip, arccosh(|t|/c) - (pi kappa/A) sgn(t) sqrt(t^2 - c^2), from the load;
        0 inside.
        """
        del excess
        m, c = self.at(advance)
        t = np.asarray(x, dtype=float) - m
        root = np.sqrt(np.maximum((np.abs(t) - c) * (np.abs(t) + c), 0.0))
        arccosh = np.arcsinh(root / np.where(c > 0, c, np.inf))
        return self.tangential_fraction * arccosh - self.lean * np.sign(t) * root

    def inverse_root(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """Traction at points x by a unit of load on one contact interval, times pi [1/length]:
        (tangential_fraction - lean t)/sqrt((c - t)(c + t)), 0 outside.

        t is the distance from the middle of the interval, c its half-length.
        `tangential_fraction` is the part that is symmetric, `lean` the rate at which tilt leans it.

        Parameters
        ----------
        x
            points, which carry their sign [length]
        excess
            load of the interval minus that at which the edge of contact reaches x [force per
            thickness]
        advance
            load of the interval [force per thickness]
        """
        m, c = self.at(advance)
        face_middle, face_half = self.intervals.face
        places = np.asarray(x, dtype=float)
        load_above = np.asarray(excess, dtype=float)
        t = places - m
        difference_of_squares = (c - t) * (c + t)
        is_beside_face = np.abs(places - face_middle) >= face_half
        is_near = (difference_of_squares < _NEXT * c * c) & (load_above > 0) & is_beside_face
        if np.any(is_near):
            # Next to the edge c - t is how far the edge has moved beyond x.
            edge_side, upper_load, load_rise, upper_half_width = (
                np.broadcast_to(values, is_near.shape)[is_near]
                for values in (np.sign(t), advance, load_above, c)
            )
            to_edge = self.intervals.growth(edge_side, upper_load, load_rise)
            difference_of_squares[is_near] = to_edge * (2 * upper_half_width - to_edge)
        return (self.tangential_fraction - self.lean * t) / np.sqrt(
            np.where(difference_of_squares > 0, difference_of_squares, np.inf)
        )

    def logarithm(self, c: Array) -> Array:
        """ln(2 L/c); 0 for c = 0, where it is multiplied by the load."""
        return np.log(2 * self.datum_length / np.where(c > 0, c, 2 * self.datum_length))

    def log_ratio(self, load: ArrayLike) -> Array:
        """What `rigid` asks for: ln(2 L/c) + (pi kappa/A) m, with mu added to m, or mu alone."""
        m, c = self.at(load)
        moment_arm = self.tangential_fraction * m - self.lean * c * c / 2
        if self.rigid == "moment":
            return moment_arm
        displacement_rate = self.tangential_fraction * self.logarithm(c) + self.lean * m
        if self.rigid == "loop":
            return self.tangential_fraction * displacement_rate + self.lean * moment_arm
        return displacement_rate

    def log_distance(self, load: ArrayLike) -> Array:
        """Integral from no load up to `load` of a rigid movement per load, in closed form; which
        movement, `rigid` says [force per thickness].

        It is the moment of the pressure ("moment"); or pi/A times the approach, without the part of
        the datum ("displacement"); or that plus `lean` times the moment ("loop"), whose loop
        encloses W.

        # notation: m and c are the centre and the half-length of the contact under `load` [length]
        """
        load = np.asarray(load, dtype=float)
        m, c = self.intervals.at(load)
        tilt = self.intervals.tilt_without_load + self.intervals.tilt_per_load * load
        moment = self.shape.moment(m, c, tilt) / self._compliance
        if self.rigid == "moment":
            return moment
        approach_of_start = self.shape.approach(
            *self.intervals.start, self.intervals.tilt_without_load
        )
        approach = self.shape.approach(m, c, tilt) - approach_of_start
        approach_over_unit = np.pi / self._compliance * approach + load * self.logarithm(c)
        if self.rigid == "loop":
            return approach_over_unit + self.lean * moment
        return approach_over_unit

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P of eta times `log_ratio`."""
        eta, weight = self._nodes(np.zeros(np.shape(load)), np.asarray(load, dtype=float))
        return np.asarray(np.sum(weight * eta * self.log_ratio(eta), axis=-1))

    def dissipation_kernel(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) >= 0 [force per thickness], which the friction work of slip zones gathers;
        from P = `load` and P - P_c = `slipped`.

        It is the integral over loads eta from P_c to P of r(P_c) - r(eta). r is the rate per load
        of U + kappa m_q, U the tangential displacement, m_q the moment of the shear, kappa the tilt
        per load.
        """
        load, slipped = np.broadcast_arrays(
            np.asarray(load, dtype=float), np.asarray(slipped, dtype=float)
        )
        loop = replace(self, rigid="loop")
        edge_load = np.maximum(load - slipped, 0.0)
        rate_at_edge = loop.log_ratio(edge_load)
        kernel = np.array(
            slipped * rate_at_edge - (loop.log_distance(load) - loop.log_distance(edge_load))
        )
        is_close = slipped < _APART * load
        if np.any(is_close):
            eta, weights = crowded_nodes(edge_load[is_close], load[is_close])
            difference = rate_at_edge[is_close][:, None] - loop.log_ratio(eta)
            kernel[is_close] = np.sum(weights * difference, axis=-1)
        return np.maximum(kernel, 0.0)

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Error of the method `name` by the round-off of m and c; `dissipation_kernel` is a
        difference of larger numbers.
        """
        size = np.abs(getattr(self, name)(*arguments))
        if name == "dissipation_kernel":
            size = size + np.abs(arguments[0])
        return self.noise * size
