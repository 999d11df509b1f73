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

    dp/d eta = [1/pi - (kappa/A) t]/sqrt(c^2 - t^2)                                       inside, q = int M' dp
    s = (A/pi) int M' [arccosh(|t|/c) - (pi kappa/A) sgn(t) sqrt(t^2 - c^2)] d eta        outside
    U = (A/pi) int M' [ln(2 L/c) + (pi kappa/A) m] d eta                                  of x = 0
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
from numpy.typing import ArrayLike, NDArray

from scenes import InputError, NotFoundError, ProfileDataError
from scenes.chebyshev import Pieces, Unresolved, halved
from semi_analytic.quadrature import ROOTS, Rule, crowded, gauss, graded, panels

Array = NDArray[np.float64]

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
    whole: Array
    odd: Array


class Angles(NamedTuple):
    """Of the knots over contacts of any shape, with a new last axis: theta, its sine and cosine."""

    theta: Array
    sine: Array
    cosine: Array


class ConvexProfile(abc.ABC):
    """A profile that bends down nowhere, and its contact under any load and tilt.

    Attributes
    ----------
    knots : (n,) ascending: where h'' is not smooth [length]
    size : a length about which its contacts may be [length]
    extent : ends of the profile [length]
    noise : relative error of h', which that of m and c follows
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
        shape = np.broadcast_shapes(*(np.shape(each) for each in arguments))
        wide = [
            np.reshape(each, (1,) * (len(shape) - np.ndim(each)) + np.shape(each))
            for each in arguments
        ]
        rows, result = (
            max(_VALUES // max(self._width * math.prod(shape[1:]), 1), 1),
            np.empty(shape),
        )
        for k in range(0, shape[0] if shape else 1, rows):
            here = slice(k, k + rows) if shape else ()
            result[here] = function(
                *(each[here] if shape and len(each) > 1 else each for each in wide)
            )
        return result

    def contact(self, product: ArrayLike, tilt: ArrayLike) -> tuple[Array, Array]:
        """m and c of the contact under A P and a tilt, arrays that broadcast: least int h d theta +
        pi alpha m - A P ln(c).

        Newton's method for what both ends carry, held back by the slope of that sum, which is
        convex.

        Raises
        ------
        InputError
            For a tilt steeper than the sides, and for a contact that reaches beyond the profile.
        """
        product, tilt = np.broadcast_arrays(
            np.asarray(product, dtype=float), np.asarray(tilt, dtype=float)
        )
        middle, half = np.array(self.touch(tilt)), np.zeros(product.shape)
        if not np.all(np.isfinite(middle)):
            raise InputError(
                "load: the tilt is steeper than the sides of the profile: it touches nowhere along"
                " its sides"
            )
        pressed = product > 0
        wanted, tilt, start = product[pressed], tilt[pressed], middle[pressed]
        # From a wider contact: what either end carries is nearly a convex function of it, and
        # hardly one of the other.
        low, high = start - self.size, start + self.size
        if len(self.knots):
            low, high = (
                np.minimum(low, self.knots[0] - self.size),
                np.maximum(high, self.knots[-1] + self.size),
            )
        m, c, shift, wider = (low + high) / 2, (high - low) / 2, 0 * start, 0 * start
        fall = np.full(start.shape, np.inf)
        for _ in range(_STEPS):
            at, half_length = m + shift, c + wider
            found = self.balance(at, half_length)
            lean, missing = np.pi * (found.mean_slope + tilt), (wanted - found.load) / half_length
            # Half of a step beyond which the sum would rise as steeply as half of its fall before.
            taken = lean * shift - missing * wider <= fall / 2
            m, c = np.where(taken, at, m), np.where(taken, half_length, c)
            whole, odd = found.whole, found.odd + lean / half_length
            odd = np.where(whole * whole > 1.1 * odd * found.odd, odd, found.odd)
            rate = whole * whole - odd * found.odd
            rises = rate > 0
            rate = np.where(rises, rate, 1.0)
            far = np.where(rises, -(lean * whole + odd * missing) / rate, 0.0)
            wide = np.where(rises, (whole * missing + lean * found.odd) / rate, c)
            # Neither end moves by more than c, nor past what touches first.
            left = np.clip(far - wide, -c, 0.9 * np.maximum(start - m + c, 0.0))
            right = np.clip(far + wide, 0.9 * np.minimum(start - m - c, 0.0), c)
            shift, wider = (
                np.where(taken, (left + right) / 2, shift / 2),
                np.where(taken, (right - left) / 2, wider / 2),
            )
            fall = np.where(taken, np.abs(lean * shift - missing * wider), fall)
            # The next step would be about the power 3/2 of this one.
            if np.all(np.maximum(np.abs(shift), np.abs(wider)) <= 1e-10 * c + 1e-14 * np.abs(m)):
                m, c = m + shift, c + wider
                break
        else:
            raise InputError(
                "profile: its sides do not rise enough to carry the load under this tilt"
            )
        middle[pressed], half[pressed] = m, c
        ends = float(np.min(middle - half, initial=0.0)), float(np.max(middle + half, initial=0.0))
        if ends[0] < self.extent[0] * (1 + _NOISE) or ends[1] > self.extent[1] * (1 + _NOISE):
            raise ProfileDataError(
                f"profile: the load needs a contact from {ends[0]:.6g} to {ends[1]:.6g}, the"
                f" profile goes from {self.extent[0]:.6g} to {self.extent[1]:.6g}"
            )
        return middle, half


@dataclass(frozen=True, eq=False)
class PiecewiseParabola(ConvexProfile):
    """A profile whose h'' is constant between knots.

    Attributes
    ----------
    knots, curvature : (n,) ascending [length], (n + 1,) of the pieces between and beyond [1/length]
    slope, height : h' and h at the first knot
    extent : ends of the profile [length]
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
        return 1 / float(self.curvature[0]) if self.is_parabola and self.touch(0.0) == 0 else None

    @cached_property
    def is_parabola(self) -> bool:
        """Whether h'' is the same everywhere: of such a profile m and c have closed forms."""
        return bool(np.all(self.jumps == 0))

    def angles(self, m: Array, c: Array) -> Angles:
        """Of the knots over contacts of centre m and half-length c; 0 beyond the right end, pi
        beyond the left one.
        """
        away, size = self.knots - m[..., None], np.asarray(c)[..., None]
        cosine = np.clip(
            np.where(size > 0, away / np.where(size > 0, size, 1.0), np.sign(away)), -1.0, 1.0
        )
        return Angles(np.arccos(cosine), np.sqrt((1 - cosine) * (1 + cosine)), cosine)

    @cached_property
    def slopes(self) -> Array:
        """h' at the knots."""
        return np.concatenate(
            [[self.slope], self.slope + np.cumsum(self.curvature[1:-1] * np.diff(self.knots))]
        )

    def touch(self, tilt: ArrayLike) -> Array:
        """Where h' + alpha = 0: the middle of that place, infinite if there is none [length]."""
        wanted, last = -np.asarray(tilt, dtype=float), len(self.knots) - 1
        first, after = (
            np.searchsorted(self.slopes, wanted, "left"),
            np.searchsorted(self.slopes, wanted, "right"),
        )
        known, bend = np.clip(first - 1, 0, last), self.curvature[first]
        apart = wanted - self.slopes[known]
        with np.errstate(divide="ignore", invalid="ignore"):
            between = self.knots[known] + np.where(
                bend > 0, apart / bend, np.copysign(np.inf, apart)
            )
        level = (self.knots[np.minimum(first, last)] + self.knots[np.maximum(after - 1, 0)]) / 2
        return np.where(after > first, level, between)

    def balance(self, m: Array, c: Array) -> Balance:
        """What a contact carries. Knots left of m count by (b - x)_+, so that ends next to a knot
        keep their digits.
        """
        number = np.searchsorted(self.knots, m)
        known, bend = np.maximum(number - 1, 0), self.curvature[number]
        away = self.knots - m[..., None]
        depth = np.clip(1 - np.abs(away) / np.where(c > 0, c, 1.0)[..., None], 0.0, 1.0)
        theta, sine, side = (
            2 * np.arcsin(np.sqrt(depth / 2)),
            np.sqrt(depth * (2 - depth)),
            np.where(away >= 0, 1.0, -1.0),
        )
        cosine, square = 1 - depth, np.square(theta)
        # sin - theta cos and theta - sin cos, both by their series where they would cancel.
        mean, load, small = sine - theta * cosine, theta - sine * cosine, theta < _SMALL
        if np.any(small):
            mean = np.where(
                small, theta * square * np.polynomial.polynomial.polyval(square, _OF_MEAN), mean
            )
            load = np.where(
                small, theta * square * np.polynomial.polynomial.polyval(square, _OF_LOAD), load
            )
        return Balance(
            c * (mean @ self.jumps) / np.pi + self.slopes[known] + bend * (m - self.knots[known]),
            c * c / 2 * (np.pi * bend + (side * load) @ self.jumps),
            np.pi * bend + (side * theta) @ self.jumps,
            sine @ self.jumps,
        )

    def contact(self, product: ArrayLike, tilt: ArrayLike) -> tuple[Array, Array]:
        if not self.is_parabola:
            return super().contact(product, tilt)
        bend = self.curvature[0]
        product, tilt = np.broadcast_arrays(
            np.asarray(product, dtype=float), np.asarray(tilt, dtype=float)
        )
        return self.knots[0] - (self.slope + tilt) / bend, np.sqrt(
            2 * np.maximum(product, 0.0) / (np.pi * bend)
        )

    # --- what follows from a contact

    @property
    def _width(self) -> int:
        return len(self.knots)

    def _pressure(self, x: Array, m: Array, c: Array) -> Array:
        if self.is_parabola:
            return np.asarray(
                np.pi * self.curvature[0] * np.sqrt(np.maximum((c - x + m) * (c + x - m), 0.0))
            )
        t, over = x - m, self.angles(m, c)
        root = np.sqrt(np.maximum((c - t) * (c + t), 0.0))[..., None]
        size, knot = np.where(c > 0, c, 1.0)[..., None], self.knots - x[..., None]
        # ln|sin((theta_x + theta)/2)/sin((theta_x - theta)/2)|
        one, other = root / size * (1 + over.cosine), over.sine * (1 + t[..., None] / size)
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.where(
                (knot == 0) | (over.sine == 0), 0.0, np.log(np.abs((one + other) / (one - other)))
            )
        terms = root * over.theta - knot * np.where(np.isfinite(logarithm), logarithm, 0.0)
        return np.where(
            root[..., 0] > 0, terms @ self.jumps + np.pi * self.curvature[0] * root[..., 0], 0.0
        )

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        t, over = x - m, self.angles(m, c)
        distance = np.maximum(np.abs(t), c)
        root = np.sqrt((distance - c) * (distance + c))
        angle = np.where(c > 0, np.arcsinh(root / np.where(c > 0, c, 1.0)), 0.0)
        area = distance * root - c * c * angle
        side, share = (
            np.sign(t)[..., None],
            np.divide(root, distance + c, out=np.zeros(t.shape), where=distance + c > 0)[..., None],
        )
        tangent = (
            np.where(side > 0, over.sine, share * over.sine),
            np.where(side > 0, share, 1.0) * (1 + over.cosine),
        )
        turned = np.where(
            over.cosine <= -1, np.pi, np.where(over.cosine >= 1, 0.0, 2 * np.arctan2(*tangent))
        )
        knot, sine, whole = (
            x[..., None] - self.knots,
            c[..., None] * over.sine,
            c[..., None] * over.cosine,
        )
        terms = np.square(np.maximum(knot, 0.0)) / 2 - knot * knot * turned / (2 * np.pi)
        terms += (
            over.theta * area[..., None]
            - side * sine * (root[..., None] - side * whole * angle[..., None])
        ) / (2 * np.pi)
        return np.where(np.abs(t) > c, terms @ self.jumps + self.curvature[0] / 2 * area, 0.0)

    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        theta, sine, cosine = self.angles(m, c)
        away, knot = m - self.knots[0], self.knots - m[..., None]
        bent = (
            theta * knot * knot + np.square(c)[..., None] * (theta / 2 - 1.5 * sine * cosine)
        ) @ self.jumps
        plain = self.height + self.slope * away + self.curvature[0] / 2 * (away * away + c * c / 2)
        return np.asarray(plain + np.asarray(tilt) * m + bent / (2 * np.pi))

    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        theta, sine, cosine = self.angles(m, c)
        half, knot = c[..., None], self.knots - m[..., None]
        bent = (
            half * (sine - sine**3 / 3 - sine * cosine * cosine / 2) - theta * knot / 2
        ) @ self.jumps
        level = np.asarray(tilt) + self.slope + self.curvature[0] * (m - self.knots[0])
        return np.asarray(m * self.balance(m, c).load + c * c * (bent + np.pi / 2 * level))


# Share of c, or of the distance to a knot, within which h'' stands for a difference quotient of h'.
_NEAR = 1e-5


@dataclass(frozen=True, eq=False)
class CurvedProfile(ConvexProfile):
    """A convex profile given by h, h' and h'': averages over theta, x = m + c cos(theta), cut at
    the knots.

    # notation: <f> = (1/pi) int_0^pi f(xi) d theta, xi = m + c cos(theta), t = xi - m; x = m +- c
    cosh(u) outside

        pi A p = pi sqrt(c^2 - (x - m)^2) <(h'(xi) - h'(x))/(xi - x)>         A int x p = pi <(m t + t^2 - c^2/2) h'>
        gap = <+-c sinh(u) [(h(x) - h(xi))/(x - xi) - h'(xi)] - u t h'(xi)>    approach = <h> + alpha m + (A P/pi) ln(2 L/c)

    With h' = sum b_k cos(k theta) these are p = (1/A) sum b_k sin(k theta) and its potential, by
    Glauert's integrals.

    Attributes
    ----------
    height, gradient, bend : h, h' and h''
    rule : on a part between knots; `ROOTS` for singular ends
    exponent : n of |x|^n near the knot x = 0
    noise : relative error of h'
    """

    knots: Array
    size: float
    height: Callable[[Array], Array]
    gradient: Callable[[Array], Array]
    bend: Callable[[Array], Array]
    rule: Rule = ROOTS
    exponent: float = 2.0
    extent: tuple[float, float] = (-np.inf, np.inf)
    noise: float = _NOISE

    @property
    def breaks(self) -> Array:
        return self.knots

    def touch(self, tilt: ArrayLike) -> Array:
        wanted, reach = -np.asarray(tilt, dtype=float), self.size
        while self.gradient(np.array(reach)) < np.max(np.abs(wanted)) and reach < 1e9 * self.size:
            reach = 2 * reach
        ends = []
        for above in (np.greater_equal, np.greater):
            low, high = np.full(wanted.shape, -reach), np.full(wanted.shape, reach)
            for _ in range(64):
                middle = (low + high) / 2
                beyond = above(self.gradient(middle), wanted)
                low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
            ends.append(low if above is np.greater else high)
        return np.where(
            np.abs(wanted) <= self.gradient(np.array(reach)), (ends[0] + ends[1]) / 2, np.inf
        )

    def _nodes(self, m: Array, c: Array) -> tuple[Array, Array, Array]:
        """xi, xi - m and weights of averages over contacts, with a new last axis."""
        m, c = (each[..., None] for each in np.broadcast_arrays(m, c))
        away = self.knots[::-1] - m
        inner = np.arctan2(np.sqrt(np.maximum((c - away) * (c + away), 0.0)), away)
        ends = np.concatenate([0 * m, inner, 0 * m + np.pi], axis=-1)
        places = np.concatenate([m + c, np.clip(away + m, m - c, m + c), m - c], axis=-1)
        length, upper = np.diff(ends)[..., None], self.rule.up < 0.5
        # From the end next to a node, so that its distance from a knot keeps its digits.
        turn = np.where(upper, length * self.rule.up, -length * self.rule.down)
        base = np.where(upper, places[..., :-1, None], places[..., 1:, None])
        sine, cosine = (
            np.where(upper, each[..., :-1, None], each[..., 1:, None])
            for each in (np.sin(ends), np.cos(ends))
        )
        half = np.sin(turn / 2)
        xi = base - 2 * c[..., None] * half * (sine * np.sqrt(1 - half * half) + cosine * half)
        weight = length * self.rule.share / np.pi
        if len(self.knots):
            # What the rule leaves out of |x|^(n - 2) is a geometric series.
            rest = 1 + 1 / math.expm1((self.exponent - 1) * self.rule.share[0] / self.rule.up[0])
            weight[..., 0] *= np.where(places[..., :-1] == 0, rest, 1.0)
            weight[..., -1] *= np.where(places[..., 1:] == 0, rest, 1.0)
        flat = (*xi.shape[:-2], xi.shape[-2] * xi.shape[-1])
        return xi.reshape(flat), (xi - m[..., None]).reshape(flat), weight.reshape(flat)

    def balance(self, m: Array, c: Array) -> Balance:
        xi, t, weight = self._nodes(m, c)
        slope, bend = weight * self.gradient(xi), np.pi * weight * self.bend(xi)
        cosine = t / np.where(c > 0, c, 1.0)[..., None]
        return Balance(
            *(np.sum(each, axis=-1) for each in (slope, np.pi * slope * t, bend, bend * cosine))
        )

    @property
    def _width(self) -> int:
        return (len(self.knots) + 1) * len(self.rule.up)

    def _pressure(self, x: Array, m: Array, c: Array) -> Array:
        xi, _, weight = self._nodes(m, c)
        place, root = np.asarray(x)[..., None], np.sqrt(np.maximum((c - x + m) * (c + x - m), 0.0))
        away = xi - place
        apart = np.min(np.abs(place - self.knots), axis=-1, initial=np.inf, keepdims=True)
        near = np.nonzero(np.abs(away) < _NEAR * np.minimum(apart, c[..., None]))
        middle, away[near] = (place + away / 2)[near] if len(near[0]) else away[near], np.inf
        quotient = (self.gradient(xi) - self.gradient(place)) / np.where(away == 0, np.inf, away)
        quotient[near] = self.bend(middle)
        return np.asarray(np.pi * root * np.sum(weight * quotient, axis=-1))

    def _gap(self, x: Array, m: Array, c: Array) -> Array:
        xi, t, weight = self._nodes(m, c)
        distance = np.maximum(np.abs(x - m), c)
        root = np.sqrt((distance - c) * (distance + c))
        angle, place = (
            np.where(c > 0, np.arcsinh(root / np.where(c > 0, c, 1.0)), 0.0),
            np.asarray(x)[..., None],
        )
        away, slope = place - xi, self.gradient(xi)
        chord = np.divide(
            self.height(place) - self.height(xi), away, out=np.zeros(away.shape), where=away != 0
        )
        values = (np.sign(x - m) * root)[..., None] * (chord - slope) - angle[..., None] * t * slope
        return np.asarray(np.sum(weight * values, axis=-1))

    def approach(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        xi, _, weight = self._nodes(m, c)
        return np.asarray(np.sum(weight * self.height(xi), axis=-1) + np.asarray(tilt) * m)

    def moment(self, m: Array, c: Array, tilt: ArrayLike) -> Array:
        del tilt
        xi, t, weight = self._nodes(m, c)
        return np.asarray(
            np.pi
            * np.sum(
                weight * self.gradient(xi) * (m[..., None] * t + t * t - c[..., None] ** 2 / 2),
                axis=-1,
            )
        )


@dataclass(frozen=True, eq=False)
class NestedIntervals:
    """Contacts I(eta) of a convex profile under the loads eta and the tilts alpha_0 + kappa eta, by
    series.

    m and c are series of the root of eta - eta_b behind each load eta_b at which an end meets a
    knot.

    Attributes
    ----------
    shape, product : the profile, A
    tilt, slope : alpha_0 and kappa [1/force per thickness]
    most : the largest load that is asked for
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
        return float(self.start[0]), (
            0.0 if self.shape.radius is not None else float(self._series[3](0.0))
        )

    @cached_property
    def break_loads(self) -> Array:
        """Loads at which an end of I(eta) is at a knot, ascending."""
        loads = self.load(self.shape.breaks)
        return np.unique(loads[np.isfinite(loads) & (loads > 1e-12 * self.most)])

    @cached_property
    def _series(self) -> tuple[Array, Array, Pieces, Pieces]:
        """Loads behind which stretches begin and their places on one axis; m and c over that
        axis.
        """
        marks = np.concatenate(
            [[0.0], self.break_loads[self.break_loads < self.most * (1 - 1e-9)], [self.most]]
        )
        places, found = np.concatenate([[0.0], np.cumsum(np.sqrt(np.diff(marks)))]), []
        # Over 4e-15: beside a flat the last digits of a contact are noise.
        floor = 0.1 * self.shape.noise / 4e-15 * self.scale
        for low, high in pairwise(marks.tolist()):
            ends = np.array([0.0, math.sqrt(high - low)])
            both = (
                halved(lambda v, k=k, low=low: self.exactly(low + v * v)[k], ends, floor)  # type: ignore[misc]
                for k in (0, 1)
            )
            try:
                found.append(tuple(both))
            except Unresolved as fault:
                raise NotFoundError(
                    f"no contact was found under the tilt {self.tilt:.6g} and loads of about"
                    f" {low:.6g}"
                ) from fault
        middle, half = (
            Pieces(
                np.concatenate(
                    [
                        [0.0],
                        *(
                            piece.edges[1:] + place
                            for piece, place in zip(pieces, places[:-1], strict=True)
                        ),
                    ]
                ),
                np.concatenate([piece.coefficients for piece in pieces], axis=1),
            )
            for pieces in zip(*found, strict=True)
        )
        return marks[:-1], places, middle, half

    def at(self, load: ArrayLike) -> tuple[Array, Array]:
        """m and c of I(eta)."""
        if self.shape.radius is not None:
            return self.exactly(load)
        eta = np.clip(np.asarray(load, dtype=float), 0.0, self.most)
        marks, places, middle, half = self._series
        number = np.searchsorted(marks, eta, side="right") - 1
        place = np.minimum(places[number] + np.sqrt(eta - marks[number]), places[number + 1])
        return middle(place), np.where(eta > 0, np.maximum(half(place), 0.0), 0.0)

    def growth(self, side: Array, load: Array, rise: Array) -> Array:
        """How far the end of I(eta) on a side, +1 or -1, has moved outwards while eta rose by
        `rise` to `load` [length], (n,) each.

        From the rate: the difference of two ends that are next to each other would be what their
        series leave out.
        """
        if self.shape.radius is not None:
            (_, wide), (_, narrow) = self.exactly(load), self.exactly(load - rise)
            return rise * (
                2 * self.product * self.shape.radius / np.pi / (wide + narrow)
                - side * self.shape.radius * self.slope
            )
        marks, places, middle, half = self._series
        number, total, (node, share) = (
            np.searchsorted(marks, load, side="right") - 1,
            np.zeros(load.shape),
            gauss(8),
        )
        outer = np.sqrt(load - marks[number])
        while np.any(number >= 0):
            above = np.minimum(rise, outer * outer)
            step = above / np.maximum(outer + np.sqrt(outer * outer - above), 1e-300)
            low, high = places[number][:, None], np.nextafter(places[number + 1], 0.0)[:, None]
            v = np.clip(low + (outer[:, None] - step[:, None] * node), low, high)
            total += step * np.sum(
                share * (half.derivative(v) + side[:, None] * middle.derivative(v)), axis=1
            )
            rise, number = rise - above, np.where(rise > above, number - 1, -1)
            outer = places[number + 1] - places[number]
        return total

    def load(self, x: Array) -> Array:
        """P_x: the load at which x is an end of I(eta) [force per thickness]; infinite where none
        up to the largest is.

        With x as an end the mean slope falls with c: Newton's method, kept in a bracket.
        """
        middle, half = self.exactly(self.most)
        reached = np.abs(x - middle) <= half * (1 + 1e-8)
        place, lean = x[reached], self.slope / self.product
        side = np.where(place < float(self.shape.touch(self.tilt)), -1.0, 1.0)
        low, high = np.zeros(place.shape), np.full(place.shape, 2.1 * self.scale)
        c = high / 2
        for _ in range(_STEPS):
            found = self.shape.balance(place - side * c, c)
            excess = side * (found.mean_slope + self.tilt) + side * lean * found.load
            rate = (found.whole - side * found.odd) * (1 / np.pi - side * lean * c)
            low, high = np.where(excess > 0, c, low), np.where(excess > 0, high, c)
            new = c + excess / np.where(rate > 0, rate, np.inf)
            inside = (rate > 0) & (new >= low) & (new <= high)
            new = np.where(inside, new, (low + high) / 2)
            done = inside & (np.abs(new - c) <= 1e-10 * c) | (high - low <= 4e-16 * self.scale)
            c = new
            if np.all(done):
                break
        result = np.full(x.shape, np.inf)
        result[reached] = self.shape.balance(place - side * c, c).load / self.product
        return np.where(result <= self.most * (1 + 1e-9), result, np.inf)


@dataclass(frozen=True, eq=False)
class TiltedProfile:
    """A convex profile under the tilt alpha_0 + kappa eta. Arrays broadcast; points x carry their
    sign.

    Attributes
    ----------
    intervals : I(eta)
    datum_length : L, distance of the datum of rigid movements [length]
    rigid : what `log_ratio` and its integrals are over A/pi: the rate of U, of U + kappa m_q
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
        return np.asarray(
            np.maximum(self.shape.pressure(x, m[:, None], c[:, None]), 0.0)
            / (np.pi * self._product)
        )

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
        wanted = np.where(load > 0, moment, 0.0)
        if self.shape.radius is not None:
            return -wanted / (self.shape.radius * np.where(load > 0, load, np.inf))

        pairs, which = np.unique(np.stack([load, wanted]), axis=1, return_inverse=True)
        load, wanted = pairs

        low, high, tilt = (
            np.full(load.shape, -np.inf),
            np.full(load.shape, np.inf),
            np.zeros(load.shape),
        )
        for _ in range(_STEPS):
            m, c = self.under(load, tilt)
            excess, half = self.moment(m, c, load, tilt) - wanted, np.where(c > 0, c, 1.0)
            low, high = np.where(excess > 0, tilt, low), np.where(excess > 0, high, tilt)
            # A change of tilt adds -(d alpha/A) t/sqrt(c^2 - t^2) to p. No step moves a contact by
            # more than about a third of it.
            most = self._product * load / (4 * half)
            new = tilt + np.clip(2 * self._product * excess / (np.pi * half**2), -most, most)
            new = np.where((new >= low) & (new <= high), new, (low + high) / 2)
            change, tilt = np.abs(new - tilt), new
            if np.all(change <= 1e-9 * most):
                break
        else:
            raise NotFoundError(
                "load: no tilt was found at which the contact carries the moment that is stated"
            )
        return np.where(load > 0, tilt, 0.0)[which.ravel()]

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
        return load * self.pressure(place, load) - np.sum(
            weight * self.pressure(place[..., None], eta), axis=-1
        )

    def _nodes(self, begin: Array, end: Array) -> tuple[Array, Array]:
        """Nodes and weights on loads, cut at those at which an end meets a knot, a new last
        axis.
        """
        if not len(self.break_loads):
            return graded(begin, end)
        found = panels(begin, end, self.break_loads)
        shape = (*np.shape(end), -1)
        return found.at.reshape(shape), found.weight.reshape(shape)

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^eta of the kernel of slip while x is open: pi/A times what its gap closes by [force
        per thickness].
        """
        x = np.asarray(x, dtype=float)
        closed = self.shape.gap(x, *self.intervals.start) - self.shape.gap(
            x, *self.intervals.at(load)
        )
        return np.maximum(closed, 0.0) * np.pi / self._product

    def slip_integral_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """The same with eta in front [force^2 per thickness^2]."""
        x, load = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(load, dtype=float))
        eta, weight = self._nodes(np.zeros(load.shape), np.minimum(load, self.load(x)))
        return np.asarray(
            np.sum(weight * eta * self.arccosh_ratio(x[..., None], 0.0, eta), axis=-1)
        )

    def arccosh_ratio(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """The kernel of slip, arccosh(|t|/c) - (pi kappa/A) sgn(t) sqrt(t^2 - c^2), from the load;
        0 inside.
        """
        del excess
        m, c = self.at(advance)
        t = np.asarray(x, dtype=float) - m
        root = np.sqrt(np.maximum((np.abs(t) - c) * (np.abs(t) + c), 0.0))
        return (
            self.share * np.arcsinh(root / np.where(c > 0, c, np.inf))
            - self.lean * np.sign(t) * root
        )

    def inverse_root(self, x: ArrayLike, excess: ArrayLike, advance: ArrayLike) -> Array:
        """pi dp/d eta from the load and what it is above P_x; 0 outside."""
        (m, c), (start, least) = self.at(advance), self.intervals.face
        place, above = np.asarray(x, dtype=float), np.asarray(excess, dtype=float)
        t = place - m
        square = (c - t) * (c + t)
        near = (square < _NEXT * c * c) & (above > 0) & (np.abs(place - start) >= least)
        if np.any(near):
            side, load, rise, half = (
                np.broadcast_to(each, near.shape)[near] for each in (np.sign(t), advance, above, c)
            )
            square[near] = (gap := self.intervals.growth(side, load, rise)) * (2 * half - gap)
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
        return self.share * shift + self.lean * arm if self.rigid == "loop" else shift

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P of `log_ratio`."""
        load = np.asarray(load, dtype=float)
        m, c = self.intervals.at(load)
        turned = self.intervals.tilt + self.intervals.slope * load
        moment = self.shape.moment(m, c, turned) / self._product
        if self.rigid == "moment":
            return moment
        start = self.shape.approach(*self.intervals.start, self.intervals.tilt)
        whole = np.pi / self._product * (
            self.shape.approach(m, c, turned) - start
        ) + load * self.logarithm(c)
        return whole + self.lean * moment if self.rigid == "loop" else whole

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P of eta times `log_ratio`."""
        eta, weight = self._nodes(np.zeros(np.shape(load)), np.asarray(load, dtype=float))
        return np.asarray(np.sum(weight * eta * self.log_ratio(eta), axis=-1))

    def dissipation_kernel(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam = int_{P_c}^P of the loop's rate at P_c less that at eta [force per thickness]."""
        load, slipped = np.broadcast_arrays(
            np.asarray(load, dtype=float), np.asarray(slipped, dtype=float)
        )
        loop, front = replace(self, rigid="loop"), np.maximum(load - slipped, 0.0)
        rate = loop.log_ratio(front)
        result = np.array(slipped * rate - (loop.log_distance(load) - loop.log_distance(front)))
        close = slipped < _APART * load
        if np.any(close):
            eta, weight = crowded(front[close], load[close])
            result[close] = np.sum(weight * (rate[close][:, None] - loop.log_ratio(eta)), axis=-1)
        return np.maximum(result, 0.0)

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Error of the method `name` by the round-off of m and c; `dissipation_kernel` is a
        difference of larger numbers.
        """
        value = np.abs(getattr(self, name)(*arguments))
        return self.noise * (
            value + (np.abs(arguments[0]) if name == "dissipation_kernel" else 0.0)
        )
