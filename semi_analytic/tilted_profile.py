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
from semi_analytic.quadrature import ROOTS, LogisticRule, crowded, gauss, graded, panels

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
        """A int x p."""

    def _in_parts(
        self, function: Callable[[Array, Array, Array], Array], *arguments: Array
    ) -> Array:
        """Of so many rows at a time that their knots or nodes fit into memory."""
        shape = np.broadcast_shapes(*(np.shape(argument) for argument in arguments))
        columns = []
        for argument in arguments:
            new_axes = (1,) * (len(shape) - np.ndim(argument))
            columns.append(np.reshape(argument, new_axes + np.shape(argument)))
        if not shape:
            return np.array(function(*columns))
        rows_at_once = max(_VALUES // max(self._width * math.prod(shape[1:]), 1), 1)
        values = np.empty(shape)
        for k in range(0, shape[0], rows_at_once):
            rows = slice(k, k + rows_at_once)
            parts = [column[rows] if len(column) > 1 else column for column in columns]
            values[rows] = function(*parts)
        return values

    def contact(self, product: ArrayLike, tilt: ArrayLike) -> tuple[Array, Array]:
        """m and c of the contact under A P and a tilt, arrays that broadcast: least int h d theta +
        pi alpha m - A P ln(c).

        Raises
        ------
        InputError
            For a tilt steeper than the sides, and for a contact that reaches beyond the profile.
        """
        product, tilt = np.broadcast_arrays(
            np.asarray(product, dtype=float), np.asarray(tilt, dtype=float)
        )
        middle = np.array(self.touch(tilt))
        half_width = np.zeros(product.shape)
        if not np.all(np.isfinite(middle)):
            raise InputError(
                "load: the tilt is steeper than the sides of the profile: it touches nowhere along"
                " its sides"
            )
        pressed = product > 0
        middle[pressed], half_width[pressed] = self._pressed(
            product[pressed], tilt[pressed], middle[pressed]
        )
        left = float(np.min(middle - half_width, initial=0.0))
        right = float(np.max(middle + half_width, initial=0.0))
        left_end, right_end = self.extent
        if left < left_end * (1 + _NOISE) or right > right_end * (1 + _NOISE):
            raise ProfileDataError(
                f"profile: the load needs a contact from {left:.6g} to {right:.6g}, the"
                f" profile goes from {left_end:.6g} to {right_end:.6g}"
            )
        return middle, half_width

    def _pressed(self, product: Array, tilt: Array, start: Array) -> tuple[Array, Array]:
        """m and c under A P > 0, (n,), of a profile that touches first at `start`.

        Newton's method for what both ends carry, held back by the slope of the sum that is least,
        which is convex. m and c are those of the last step that was accepted; the next trial is at
        m + `shift`, c + `widening`.
        """
        # From a wider contact: what either end carries is nearly a convex function of it, and
        # hardly one of the other.
        low = start - self.size
        high = start + self.size
        if len(self.knots):
            low = np.minimum(low, self.knots[0] - self.size)
            high = np.maximum(high, self.knots[-1] + self.size)
        m = (low + high) / 2
        c = (high - low) / 2
        shift = 0 * start
        widening = 0 * start
        fall = np.full(start.shape, np.inf)
        for _ in range(_STEPS):
            trial_m = m + shift
            trial_c = c + widening
            balance = self.balance(trial_m, trial_c)
            lean = np.pi * (balance.mean_slope + tilt)
            missing = (product - balance.load) / trial_c
            # Half of a step beyond which the sum would rise as steeply as half of its fall before.
            accepted = lean * shift - missing * widening <= fall / 2
            m = np.where(accepted, trial_m, m)
            c = np.where(accepted, trial_c, c)
            step, widening_step = _newton_step(balance, lean, missing, trial_c, c)
            # Neither end moves by more than c, nor past what touches first.
            left = np.clip(step - widening_step, -c, 0.9 * np.maximum(start - m + c, 0.0))
            right = np.clip(step + widening_step, 0.9 * np.minimum(start - m - c, 0.0), c)
            shift = np.where(accepted, (left + right) / 2, shift / 2)
            widening = np.where(accepted, (right - left) / 2, widening / 2)
            fall = np.where(accepted, np.abs(lean * shift - missing * widening), fall)
            # The next step would be about the power 3/2 of this one.
            largest_step = np.maximum(np.abs(shift), np.abs(widening))
            if np.all(largest_step <= 1e-10 * c + 1e-14 * np.abs(m)):
                return m + shift, c + widening
        raise InputError("profile: its sides do not rise enough to carry the load under this tilt")


def _newton_step(
    balance: Balance, lean: Array, missing: Array, half_width: Array, fallback: Array
) -> tuple[Array, Array]:
    """Steps of m and c (n,) of Newton's method; no shift, and wider by `fallback`, where the sum is
    not convex.
    """
    bend = balance.bend_sum
    moment = balance.bend_cosine_sum
    moment_with_lean = moment + lean / half_width
    # The full matrix only where its determinant is positive, with a margin.
    has_margin = bend * bend > 1.1 * moment_with_lean * moment
    off_diagonal = np.where(has_margin, moment_with_lean, moment)
    determinant = bend * bend - off_diagonal * moment
    is_convex = determinant > 0
    determinant = np.where(is_convex, determinant, 1.0)
    shift = -(lean * bend + off_diagonal * missing) / determinant
    widening = (bend * missing + lean * moment) / determinant
    return np.where(is_convex, shift, 0.0), np.where(is_convex, widening, fallback)


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
        """Where h' + alpha = 0: the middle of that place, infinite if there is none [length]."""
        slope = -np.asarray(tilt, dtype=float)
        last_knot = len(self.knots) - 1
        first = np.searchsorted(self.slopes, slope, "left")
        first_after = np.searchsorted(self.slopes, slope, "right")
        knot_before = np.clip(first - 1, 0, last_knot)
        curvature = self.curvature[first]
        rise = slope - self.slopes[knot_before]
        with np.errstate(divide="ignore", invalid="ignore"):
            way = np.where(curvature > 0, rise / curvature, np.copysign(np.inf, rise))
            between_knots = self.knots[knot_before] + way
        left = self.knots[np.minimum(first, last_knot)]
        right = self.knots[np.maximum(first_after - 1, 0)]
        return np.where(first_after > first, (left + right) / 2, between_knots)

    def balance(self, m: Array, c: Array) -> Balance:
        """What a contact carries. Knots left of m count by (b - x)_+, so that ends next to a knot
        keep their digits.
        """
        number = np.searchsorted(self.knots, m)
        knot_before = np.maximum(number - 1, 0)
        curvature = self.curvature[number]
        distance = self.knots - m[..., None]
        half_width = np.where(c > 0, c, 1.0)[..., None]
        depth = np.clip(1 - np.abs(distance) / half_width, 0.0, 1.0)
        theta = 2 * np.arcsin(np.sqrt(depth / 2))
        sine = np.sqrt(depth * (2 - depth))
        side = np.where(distance >= 0, 1.0, -1.0)
        of_mean, of_load = _angle_functions(theta, sine, 1 - depth)
        slope_at_middle = self.slopes[knot_before] + curvature * (m - self.knots[knot_before])
        return Balance(
            mean_slope=c * (of_mean @ self.jumps) / np.pi + slope_at_middle,
            load=c * c / 2 * (np.pi * curvature + (side * of_load) @ self.jumps),
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
        t = x - m
        if self.is_parabola:
            square = np.maximum((c - x + m) * (c + x - m), 0.0)
            return np.asarray(np.pi * self.curvature[0] * np.sqrt(square))
        knot_angles = self.angles(m, c)
        root = np.sqrt(np.maximum((c - t) * (c + t), 0.0))[..., None]
        half_width = np.where(c > 0, c, 1.0)[..., None]
        distance_to_knot = self.knots - x[..., None]
        # ln|sin((theta_x + theta)/2)/sin((theta_x - theta)/2)|, each sine times the same factor
        of_point = root / half_width * (1 + knot_angles.cosine)
        of_knot = knot_angles.sine * (1 + t[..., None] / half_width)
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log(np.abs((of_point + of_knot) / (of_point - of_knot)))
        is_zero = (distance_to_knot == 0) | (knot_angles.sine == 0) | ~np.isfinite(logarithm)
        logarithm = np.where(is_zero, 0.0, logarithm)
        terms = root * knot_angles.theta - distance_to_knot * logarithm
        pressure = terms @ self.jumps + np.pi * self.curvature[0] * root[..., 0]
        return np.where(root[..., 0] > 0, pressure, 0.0)

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        t = x - m
        theta, sine, cosine = self.angles(m, c)
        distance = np.maximum(np.abs(t), c)
        root = np.sqrt((distance - c) * (distance + c))
        u = np.where(c > 0, np.arcsinh(root / np.where(c > 0, c, 1.0)), 0.0)
        area = distance * root - c * c * u
        side = np.sign(t)[..., None]
        # 2 arctan of the tangent of half an angle, from its two legs
        zeros = np.zeros(t.shape)
        ratio = np.divide(root, distance + c, out=zeros, where=distance + c > 0)[..., None]
        opposite = np.where(side > 0, sine, ratio * sine)
        adjacent = np.where(side > 0, ratio, 1.0) * (1 + cosine)
        turned = 2 * np.arctan2(opposite, adjacent)
        turned = np.where(cosine >= 1, 0.0, turned)
        turned = np.where(cosine <= -1, np.pi, turned)
        from_knot = x[..., None] - self.knots
        knot_height = c[..., None] * sine
        knot_distance = c[..., None] * cosine
        terms = np.square(np.maximum(from_knot, 0.0)) / 2
        terms = terms - from_knot * from_knot * turned / (2 * np.pi)
        lever = root[..., None] - side * knot_distance * u[..., None]
        terms += (theta * area[..., None] - side * knot_height * lever) / (2 * np.pi)
        gap = terms @ self.jumps + self.curvature[0] / 2 * area
        return np.where(np.abs(t) > c, gap, 0.0)

    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        theta, sine, cosine = self.angles(m, c)
        from_first_knot = m - self.knots[0]
        to_knot = self.knots - m[..., None]
        of_angle = theta / 2 - 1.5 * sine * cosine
        of_jumps = (theta * to_knot * to_knot + np.square(c)[..., None] * of_angle) @ self.jumps
        square = from_first_knot * from_first_knot + c * c / 2
        of_parabola = self.height + self.slope * from_first_knot + self.curvature[0] / 2 * square
        return np.asarray(of_parabola + np.asarray(tilt) * m + of_jumps / (2 * np.pi))

    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        theta, sine, cosine = self.angles(m, c)
        half_width = c[..., None]
        to_knot = self.knots - m[..., None]
        of_angle = sine - sine**3 / 3 - sine * cosine * cosine / 2
        of_jumps = (half_width * of_angle - theta * to_knot / 2) @ self.jumps
        slope = np.asarray(tilt) + self.slope + self.curvature[0] * (m - self.knots[0])
        return np.asarray(m * self.balance(m, c).load + c * c * (of_jumps + np.pi / 2 * slope))


def _angle_functions(theta: Array, sine: Array, cosine: Array) -> tuple[Array, Array]:
    """sin - theta cos and theta - sin cos, both by their series where they would cancel."""
    of_mean = sine - theta * cosine
    of_load = theta - sine * cosine
    is_small = theta < _SMALL
    if np.any(is_small):
        square = np.square(theta)
        cube = theta * square
        series_of_mean = cube * np.polynomial.polynomial.polyval(square, _OF_MEAN)
        series_of_load = cube * np.polynomial.polynomial.polyval(square, _OF_LOAD)
        of_mean = np.where(is_small, series_of_mean, of_mean)
        of_load = np.where(is_small, series_of_load, of_load)
    return of_mean, of_load


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
        slope = -np.asarray(tilt, dtype=float)
        reach = self.size
        steepest = np.max(np.abs(slope))
        while self.gradient(np.array(reach)) < steepest and reach < 1e9 * self.size:
            reach = 2 * reach
        left, _ = self._halved(slope, reach, np.greater_equal)
        _, right = self._halved(slope, reach, np.greater)
        touches = np.abs(slope) <= self.gradient(np.array(reach))
        return np.where(touches, (left + right) / 2, np.inf)

    def _halved(
        self, slope: Array, reach: float, is_above: Callable[[Array, Array], Array]
    ) -> tuple[Array, Array]:
        """Bounds, arrays like `slope`, of the place from which on h' is above it, by halvings."""
        low = np.full(slope.shape, -reach)
        high = np.full(slope.shape, reach)
        for _ in range(64):
            middle = (low + high) / 2
            is_beyond = is_above(self.gradient(middle), slope)
            low = np.where(is_beyond, low, middle)
            high = np.where(is_beyond, middle, high)
        return low, high

    def _nodes(self, m: Array, c: Array) -> tuple[Array, Array, Array]:
        """xi, xi - m and weights of averages over contacts, with a new last axis."""
        m, c = np.broadcast_arrays(m, c)
        m = m[..., None]
        c = c[..., None]
        to_knot = self.knots[::-1] - m
        knot_root = np.sqrt(np.maximum((c - to_knot) * (c + to_knot), 0.0))
        knot_theta = np.arctan2(knot_root, to_knot)
        ends = np.concatenate([0 * m, knot_theta, 0 * m + np.pi], axis=-1)
        knots_within = np.clip(to_knot + m, m - c, m + c)
        places = np.concatenate([m + c, knots_within, m - c], axis=-1)
        length = np.diff(ends)[..., None]
        # From the end next to a node, so that its distance from a knot keeps its digits.
        from_begin = self.rule.up < 0.5

        def nearer_end(at_ends: Array) -> Array:
            return np.where(from_begin, at_ends[..., :-1, None], at_ends[..., 1:, None])

        turn = np.where(from_begin, length * self.rule.up, -length * self.rule.down)
        half_sine = np.sin(turn / 2)
        half_cosine = np.sqrt(1 - half_sine * half_sine)
        sine = nearer_end(np.sin(ends))
        cosine = nearer_end(np.cos(ends))
        way = 2 * c[..., None] * half_sine * (sine * half_cosine + cosine * half_sine)
        xi = nearer_end(places) - way
        weight = length * self.rule.weight / np.pi
        if len(self.knots):
            # What the rule leaves out of |x|^(n - 2) is a geometric series.
            ratio = (self.exponent - 1) * self.rule.weight[0] / self.rule.up[0]
            factor = 1 + 1 / math.expm1(ratio)
            weight[..., 0] *= np.where(places[..., :-1] == 0, factor, 1.0)
            weight[..., -1] *= np.where(places[..., 1:] == 0, factor, 1.0)
        shape = (*xi.shape[:-2], xi.shape[-2] * xi.shape[-1])
        return xi.reshape(shape), (xi - m[..., None]).reshape(shape), weight.reshape(shape)

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
        xi, _, weight = self._nodes(m, c)
        place = np.asarray(x)[..., None]
        root = np.sqrt(np.maximum((c - x + m) * (c + x - m), 0.0))
        way = xi - place
        to_knots = np.abs(place - self.knots)
        to_next_knot = np.min(to_knots, axis=-1, initial=np.inf, keepdims=True)
        is_near = np.nonzero(np.abs(way) < _NEAR * np.minimum(to_next_knot, c[..., None]))
        middle = (place + way / 2)[is_near] if len(is_near[0]) else way[is_near]
        way[is_near] = np.inf
        rise = self.gradient(xi) - self.gradient(place)
        quotient = rise / np.where(way == 0, np.inf, way)
        quotient[is_near] = self.bend(middle)
        return np.asarray(np.pi * root * np.sum(weight * quotient, axis=-1))

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        xi, t, weight = self._nodes(m, c)
        distance = np.maximum(np.abs(x - m), c)
        root = np.sqrt((distance - c) * (distance + c))
        u = np.where(c > 0, np.arcsinh(root / np.where(c > 0, c, 1.0)), 0.0)
        place = np.asarray(x)[..., None]
        way = place - xi
        slope = self.gradient(xi)
        rise = self.height(place) - self.height(xi)
        chord = np.divide(rise, way, out=np.zeros(way.shape), where=way != 0)
        signed_root = (np.sign(x - m) * root)[..., None]
        values = signed_root * (chord - slope) - u[..., None] * t * slope
        return np.asarray(np.sum(weight * values, axis=-1))

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
    shape, product
        the profile, A
    tilt, slope
        alpha_0 and kappa [1/force per thickness]
    most
        the largest load that is asked for
    """

    shape: ConvexProfile
    product: float
    tilt: float
    slope: float
    most: float

    def exactly(self, load: ArrayLike) -> tuple[Array, Array]:
        """m and c of I(eta) from the equations themselves."""
        eta = np.asarray(load, dtype=float)
        return self.shape.contact(self.product * eta, self.tilt + self.slope * eta)

    @cached_property
    def scale(self) -> float:
        """The largest half-length."""
        return float(self.exactly(self.most)[1])

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
        return np.unique(loads[np.isfinite(loads) & (loads > 1e-12 * self.most)])

    @cached_property
    def _series(self) -> _IntervalSeries:
        """Of all loads up to the largest."""
        breaks = self.break_loads[self.break_loads < self.most * (1 - 1e-9)]
        marks = np.concatenate([[0.0], breaks, [self.most]])
        places = np.concatenate([[0.0], np.cumsum(np.sqrt(np.diff(marks)))])
        middles = []
        halves = []
        for low, high in pairwise(marks.tolist()):
            middle, half_width = self._series_between(low, high)
            middles.append(middle)
            halves.append(half_width)
        return _IntervalSeries(
            marks[:-1], places, _side_by_side(middles, places), _side_by_side(halves, places)
        )

    def _series_between(self, low: float, high: float) -> tuple[Pieces, Pieces]:
        """m and c over v = sqrt(eta - low) between two loads next to each other."""
        ends = np.array([0.0, math.sqrt(high - low)])
        # Over 4e-15: beside a flat the last digits of a contact are noise.
        floor = 0.1 * self.shape.noise / 4e-15 * self.scale
        try:
            return (
                halved(lambda v: self.exactly(low + v * v)[0], ends, floor),
                halved(lambda v: self.exactly(low + v * v)[1], ends, floor),
            )
        except Unresolved as fault:
            raise NotFoundError(
                f"no contact was found under the tilt {self.tilt:.6g} and loads of about {low:.6g}"
            ) from fault

    def at(self, load: ArrayLike) -> tuple[Array, Array]:
        """m and c of I(eta)."""
        if self.shape.radius is not None:
            return self.exactly(load)
        eta = np.clip(np.asarray(load, dtype=float), 0.0, self.most)
        series = self._series
        number = np.searchsorted(series.begin_loads, eta, side="right") - 1
        root = np.sqrt(eta - series.begin_loads[number])
        place = np.minimum(series.places[number] + root, series.places[number + 1])
        half_width = np.maximum(series.half(place), 0.0)
        return series.middle(place), np.where(eta > 0, half_width, 0.0)

    def growth(self, side: Array, load: Array, rise: Array) -> Array:
        """How far the end of I(eta) on a side, +1 or -1, has moved outwards while eta rose by
        `rise` to `load` [length], (n,) each.

        From the rate: the difference of two ends that are next to each other would be what their
        series leave out.
        """
        radius = self.shape.radius
        if radius is not None:
            _, half_after = self.exactly(load)
            _, half_before = self.exactly(load - rise)
            widening = 2 * self.product * radius / np.pi / (half_after + half_before)
            return rise * (widening - side * radius * self.slope)
        series = self._series
        number = np.searchsorted(series.begin_loads, load, side="right") - 1
        growth = np.zeros(load.shape)
        node, share = gauss(8)
        rise_left = rise
        outer = np.sqrt(load - series.begin_loads[number])
        while np.any(number >= 0):
            rise_here = np.minimum(rise_left, outer * outer)
            inner = np.sqrt(outer * outer - rise_here)
            step = rise_here / np.maximum(outer + inner, 1e-300)
            low = series.places[number][:, None]
            high = np.nextafter(series.places[number + 1], 0.0)[:, None]
            v = np.clip(low + (outer[:, None] - step[:, None] * node), low, high)
            rate = series.half.derivative(v) + side[:, None] * series.middle.derivative(v)
            growth += step * np.sum(share * rate, axis=1)
            number = np.where(rise_left > rise_here, number - 1, -1)
            rise_left = rise_left - rise_here
            outer = series.places[number + 1] - series.places[number]
        return growth

    def load(self, x: Array) -> Array:
        """P_x: the load at which x is an end of I(eta) [force per thickness]; infinite where none
        up to the largest is.

        With x as an end the mean slope falls with c: Newton's method, kept in a bracket.
        """
        middle, half_width = self.exactly(self.most)
        is_reached = np.abs(x - middle) <= half_width * (1 + 1e-8)
        place = x[is_reached]
        tilt_per_product = self.slope / self.product
        side = np.where(place < float(self.shape.touch(self.tilt)), -1.0, 1.0)
        low = np.zeros(place.shape)
        high = np.full(place.shape, 2.1 * self.scale)
        c = high / 2
        for _ in range(_STEPS):
            balance = self.shape.balance(place - side * c, c)
            excess = side * (balance.mean_slope + self.tilt)
            excess = excess + side * tilt_per_product * balance.load
            rate = (balance.bend_sum - side * balance.bend_cosine_sum) * (
                1 / np.pi - side * tilt_per_product * c
            )
            low = np.where(excess > 0, c, low)
            high = np.where(excess > 0, high, c)
            newton = c + excess / np.where(rate > 0, rate, np.inf)
            is_inside = (rate > 0) & (newton >= low) & (newton <= high)
            new_c = np.where(is_inside, newton, (low + high) / 2)
            is_small_step = is_inside & (np.abs(new_c - c) <= 1e-10 * c)
            is_done = is_small_step | (high - low <= 4e-16 * self.scale)
            c = new_c
            if np.all(is_done):
                break
        loads = np.full(x.shape, np.inf)
        loads[is_reached] = self.shape.balance(place - side * c, c).load / self.product
        return np.where(loads <= self.most * (1 + 1e-9), loads, np.inf)


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
    least: ClassVar[float] = 0.0
    share: ClassVar[float] = 1.0
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
    def _product(self) -> float:
        """A."""
        return self.intervals.product

    @cached_property
    def lean(self) -> float:
        """pi kappa/A."""
        return float(np.pi * self.intervals.slope / self._product)

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
        return self.shape.contact(self._product * load, tilt)

    def pressure_over(self, x: Array, m: Array, c: Array) -> Array:
        """p at points (k,) of contacts (n,): (n, k)."""
        pressure = np.maximum(self.shape.pressure(x, m[:, None], c[:, None]), 0.0)
        return np.asarray(pressure / (np.pi * self._product))

    def approach(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """Normal approach at x = 0 of contacts (n,) [length]."""
        return self.shape.approach(m, c, tilt) + self._product / np.pi * load * self.logarithm(c)

    def moment(self, m: Array, c: Array, load: Array, tilt: Array) -> Array:
        """int x p of contacts (n,) [force]."""
        del load
        return self.shape.moment(m, c, tilt) / self._product

    def tilt_under(self, load: Array, moment: Array) -> Array:
        """The tilt at which contacts under the loads (n,) carry int x p = moment, by Newton's
        method; 0 where there is no load.

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

        pairs, pair_number = np.unique(np.stack([load, moment]), axis=1, return_inverse=True)
        load, moment = pairs
        low = np.full(load.shape, -np.inf)
        high = np.full(load.shape, np.inf)
        tilt = np.zeros(load.shape)
        for _ in range(_STEPS):
            m, c = self.under(load, tilt)
            excess = self.moment(m, c, load, tilt) - moment
            half_width = np.where(c > 0, c, 1.0)
            low = np.where(excess > 0, tilt, low)
            high = np.where(excess > 0, high, tilt)
            # A change of tilt adds -(d alpha/A) t/sqrt(c^2 - t^2) to p. No step moves a contact by
            # more than about a third of it.
            longest_step = self._product * load / (4 * half_width)
            step = 2 * self._product * excess / (np.pi * half_width**2)
            new_tilt = tilt + np.clip(step, -longest_step, longest_step)
            is_inside = (new_tilt >= low) & (new_tilt <= high)
            new_tilt = np.where(is_inside, new_tilt, (low + high) / 2)
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
        return np.asarray(np.maximum(value, 0.0) / (np.pi * self._product))

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
        nodes = panels(begin, end, self.break_loads)
        shape = (*np.shape(end), -1)
        return nodes.at.reshape(shape), nodes.weight.reshape(shape)

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^eta of the kernel of slip while x is open: pi/A times what its gap closes by [force
        per thickness].
        """
        x = np.asarray(x, dtype=float)
        gap_before = self.shape.gap(x, *self.intervals.start)
        gap_after = self.shape.gap(x, *self.intervals.at(load))
        return np.maximum(gap_before - gap_after, 0.0) * np.pi / self._product

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
        return self.share * arccosh - self.lean * np.sign(t) * root

    def inverse_root(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """pi dp/d eta from the load and what it is above P_x; 0 outside."""
        m, c = self.at(advance)
        face_middle, face_half = self.intervals.face
        place = np.asarray(x, dtype=float)
        load_above = np.asarray(excess, dtype=float)
        t = place - m
        square = (c - t) * (c + t)
        is_beside_face = np.abs(place - face_middle) >= face_half
        is_near = (square < _NEXT * c * c) & (load_above > 0) & is_beside_face
        if np.any(is_near):
            side, load, rise, half_width = (
                np.broadcast_to(values, is_near.shape)[is_near]
                for values in (np.sign(t), advance, load_above, c)
            )
            to_edge = self.intervals.growth(side, load, rise)
            square[is_near] = to_edge * (2 * half_width - to_edge)
        return (self.share - self.lean * t) / np.sqrt(np.where(square > 0, square, np.inf))

    def logarithm(self, c: Array) -> Array:
        """ln(2 L/c); 0 for c = 0, where it is multiplied by the load."""
        return np.log(2 * self.datum_length / np.where(c > 0, c, 2 * self.datum_length))

    def log_ratio(self, load: ArrayLike) -> Array:
        """What `rigid` asks for: ln(2 L/c) + (pi kappa/A) m, with mu added to m, or mu alone."""
        m, c = self.at(load)
        arm = self.share * m - self.lean * c * c / 2
        if self.rigid == "moment":
            return arm
        shift = self.share * self.logarithm(c) + self.lean * m
        if self.rigid == "loop":
            return self.share * shift + self.lean * arm
        return shift

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P of `log_ratio`."""
        load = np.asarray(load, dtype=float)
        m, c = self.intervals.at(load)
        tilt = self.intervals.tilt + self.intervals.slope * load
        moment = self.shape.moment(m, c, tilt) / self._product
        if self.rigid == "moment":
            return moment
        approach_of_start = self.shape.approach(*self.intervals.start, self.intervals.tilt)
        approach = self.shape.approach(m, c, tilt) - approach_of_start
        shift = np.pi / self._product * approach + load * self.logarithm(c)
        if self.rigid == "loop":
            return shift + self.lean * moment
        return shift

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P of eta times `log_ratio`."""
        eta, weight = self._nodes(np.zeros(np.shape(load)), np.asarray(load, dtype=float))
        return np.asarray(np.sum(weight * eta * self.log_ratio(eta), axis=-1))

    def dissipation_kernel(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam = int_{P_c}^P of the loop's rate at P_c less that at eta [force per thickness]."""
        load, slipped = np.broadcast_arrays(
            np.asarray(load, dtype=float), np.asarray(slipped, dtype=float)
        )
        loop = replace(self, rigid="loop")
        front = np.maximum(load - slipped, 0.0)
        rate = loop.log_ratio(front)
        kernel = np.array(slipped * rate - (loop.log_distance(load) - loop.log_distance(front)))
        is_close = slipped < _APART * load
        if np.any(is_close):
            eta, weight = crowded(front[is_close], load[is_close])
            difference = rate[is_close][:, None] - loop.log_ratio(eta)
            kernel[is_close] = np.sum(weight * difference, axis=-1)
        return np.maximum(kernel, 0.0)

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Error of the method `name` by the round-off of m and c; `dissipation_kernel` is a
        difference of larger numbers.
        """
        size = np.abs(getattr(self, name)(*arguments))
        if name == "dissipation_kernel":
            size = size + np.abs(arguments[0])
        return self.noise * size
