"""Front following: slip and stick of a parabola under any course of P, Q, bulk strain and tilt, while one stick interval remains.

# notation: A = 2/E*; p, q tractions, q > 0 on the lower face; s slip of the upper face over the lower; eps bulk strain,
#           alpha tilt; a1, a2 edges of contact, b1, b2 of stick; m, c middle and half-length of stick, zeta = x - m,
#           w = sqrt(|c^2 - zeta^2|); d = +1, -1 direction of slip; q = d (f p - q*), so that q* = 0 where they slip in direction d;
#           N = f P - d Q, T = f alpha - d eps; side = +1 right, -1 left; H principal value of int (.)/(x - xi) d xi

    h' + alpha = (A/pi) H p  in contact,    s' = (A/pi) H q - eps  everywhere         (like bodies, Dundurs' beta = 0)

The frozen slope s'(x) of the stick interval is the whole memory of friction. On stick (A/pi) H q* = F, with
F = f (h' + alpha) - d (s' + eps). The singular part of q* at an edge is K/(pi w),

    K = N - (1/A) int (zeta + side c) F/w - 2 f int_far p |xi - near edge|^(1/2)/|xi - far edge|^(1/2) d xi

with the last term where the zone at the far end slips in the opposite direction: q* = 2 f p in it. A *receding* stick edge is where
K = 0, however long the step. A contact edge that *advances in stick* freezes the s' that it meets: what it was when the step began,
and the integral over time of

    ds'/dt = d side {f [(A/pi) dP - d alpha zeta_a]/w_a - [(A/pi) dN - dT zeta]/w}     outside the contact, a: of the contact

A zone that comes to rest freezes its s' as it is, by the formula of H q* outside the stick interval. Steps end at events, and are
spectral in time between them: K of the rates of the loads is negative while an edge recedes.

Where loads turn round with bulk or tilt out of phase, slip stops at the edge of contact first, and stick has several intervals. So
it may where a front meets what a loop has left. Both are found, by the sign of the slip rate and by |q| <= f p, and refused. There
remain most courses of a few changes of the loads, and many cycles in phase. A cycle is given only where its friction work and its
closed integral of Q dU - m_q d eps agree to 1e-6; where no cycle repeats the stated error has the balance of energy in it.

Several intervals were tried with the formulas of docs/bulk-stress.md (equations, numbers and what fails: commit 5320e64), and are
not in: q* erred by 1e-5 where intervals merged, a cycle took 8 to 25 s, and no steady state was reached.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from scenes import NORMAL_LOAD, OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, Combination, InputError, LoadPath, LoadSegment
from scenes.chebyshev import clenshaw
from semi_analytic.history import check

Array = NDArray[np.float64]

ORDER = 16
"""Degree in time of a step: with steps of a sixteenth of a cycle its last coefficients are 1e-10 of the half-width."""

ERROR = 1e-8
"""What events, edges and pieces of s' leave of W, of q and of s, as share of the largest value."""

# Share of its work by which a cycle may differ from the one before and repeat it.
STEADY = 1e-8
# Panels of half an interval, ever shorter towards its end: roots of what lies close beyond the end are resolved there.
_PANELS = (0.0, 0.001, 0.006, 0.03, 0.12, 0.4, 1.0)
# What a step may leave unresolved, as share of the half-width; the shortest step, as share of the longest.
_RESOLVED, _SHORTEST = 2e-9, 1e-7
# Share of A f P that the equations of the edges may still change by up to a turning point where edges are held: a loop that closes
# there meets a stretch without q*.
_CLOSING = 1e-8
# Gap that is left where an edge comes to an old one, share of the contact: beyond it s' has another series.
_GAP = 3e-10
# Instants of a step that are sampled together.
_TOGETHER = 16
# Share of the longest step that is no time: directions are those just after, and a corner that close has been reached.
_SOON = 1e-6
# Share of the largest slip rate, and of f p0, that may have the wrong sign: rounding of edges leaves 1e-9.
_WRONG = 1e-6
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(32)
_ANGLE, _ANGLE_WEIGHT = np.pi * (1 + _NODES) / 2, np.pi / 2 * _WEIGHTS
_SIDES = ((0, -1), (1, 1))


def _graded(count: int = 10) -> tuple[Array, Array]:
    """Shares of an interval counted from one end, up to its middle, and weights: for an inverse root at that end."""
    x, w = np.polynomial.legendre.leggauss(count)
    at = np.concatenate([a + (b - a) * (1 + x) / 2 for a, b in pairwise(_PANELS)])
    return at**2 / 2, at * np.concatenate([(b - a) * w / 2 for a, b in pairwise(_PANELS)])


_HALF, _HALF_WEIGHT = _graded()
# Shares of an interval from its begin and from its end, and weights: graded towards both, and Gauss' rule.
_GRADED = np.concatenate([_HALF, 1 - _HALF]), np.concatenate([1 - _HALF, _HALF]), np.concatenate([_HALF_WEIGHT, _HALF_WEIGHT])
_PLAIN = (1 + _NODES) / 2, (1 - _NODES) / 2, _WEIGHTS / 2


class Loads(NamedTuple):
    """P, Q, eps, alpha as functions of time: `values` and `rates` return (4, n) for times (n,); `corners` in ascending order."""

    values: Callable[[Array], Array]
    rates: Callable[[Array], Array]
    corners: Array


class NotOneStickInterval(InputError):
    """The stick zone has broken into several intervals, or its edges could not be followed."""


# ------------------------------------------------------------------------------------------------- series on [-1, 1]
def _nodes(n: int) -> Array:
    return -np.cos(np.pi * np.arange(n + 1) / n)


@lru_cache
def _to_series(n: int) -> Array:
    return np.asarray(np.linalg.inv(chebyshev.chebvander(_nodes(n), n)), dtype=float)


def _fit(values: Array) -> Array:
    """Chebyshev coefficients of values at `_nodes`, (n + 1, ...)."""
    return np.asarray(_to_series(len(values) - 1) @ values)


def _value(at: Array | float, coefficients: Array) -> Array:
    return np.asarray(chebyshev.chebval(at, coefficients))


def _primitive(coefficients: Array) -> Array:
    """The integral from -1."""
    return np.asarray(chebyshev.chebint(coefficients, lbnd=-1.0), dtype=float)


def _integral(values: Array) -> float:
    """Integral over [-1, 1] of what has these values at `_nodes`."""
    return float(_value(1.0, _primitive(_fit(values))))


def _places(low: float, high: float, n: int) -> Array:
    """Points at the n + 1 nodes of a piece of s'."""
    return np.asarray(low + (high - low) * np.sin(np.pi * (_nodes(n) + 1) / 4) ** 2)


def _times(begin: float, end: float, n: int) -> Array:
    """Times at the n + 1 nodes of a step: roots of them at either end are smooth there."""
    time = _places(begin, end, n)
    time[-1] = end
    return time


def _root_beyond(zeta: Array, c: Array) -> Array:
    """sqrt(zeta^2 - c^2) > 0, also where a zone has no width yet, with nothing in it."""
    return np.sqrt(np.maximum((zeta - c) * (zeta + c), (1e-10 * c) ** 2))


# ---------------------------------------------------------------------------------------------------- the frozen slope
class Quadrature(NamedTuple):
    """Nodes on stick intervals, (k,) each: row of the interval, ascending; x, weight, s', x - b1, b2 - x."""

    row: NDArray[np.intp]
    x: Array
    weight: Array
    slope: Array
    up: Array
    down: Array

    def summed(self, values: Array) -> Array:
        """Sums over the nodes of each interval, of values (k, ...)."""
        return np.asarray(np.add.reduceat(values, np.flatnonzero(np.diff(self.row, prepend=-1)), axis=0))


class Frozen:
    """The frozen s'(x) on k pieces side by side, from left to right, and s(x).

    On a piece s' is a Chebyshev series in theta, x = low + (high - low) sin(theta/2)^2, which resolves roots at both ends. `ends`
    (k + 1,), `series` (n + 1, k); s = `slip` at the point `at`.
    """

    def __init__(self, ends: Array, series: Array, at: float = 0.0, slip: float = 0.0) -> None:
        self.ends, self.series, self.low, self.length, self._known = ends, series, ends[:-1], np.diff(ends), (at, slip)

    @cached_property
    def _whole(self) -> Array:
        """Of all pieces by Gauss' rule."""
        return self._rule(np.arange(len(self.low)), 0 * self.low, 0 * self.low + np.pi, _PLAIN)

    @cached_property
    def _rise(self) -> Array:
        """Series of s."""
        nodes, (at, slip) = _nodes(len(self.series) + 15), self._known
        rate = chebyshev.chebval(nodes, self.series) * self.length[:, None] * np.sin(np.pi * (nodes + 1) / 2) * np.pi / 4
        rise = _primitive(_fit(rate.T))
        rise[0] += np.append(0.0, np.cumsum(np.sum(rise, axis=0))[:-1])
        rise[0] += slip - float(self._at(rise, np.array([at]))[0])
        return rise

    def _theta(self, number: NDArray[np.intp], x: Array) -> Array:
        return np.asarray(2 * np.arcsin(np.sqrt(np.clip((x - self.low[number]) / self.length[number], 0, 1))))

    def _at(self, rows: Array, x: Array) -> Array:
        number = np.clip(np.searchsorted(self.ends, x) - 1, 0, len(self.low) - 1)
        return np.asarray(clenshaw(rows, number, 2 * self._theta(number, x) / np.pi - 1).reshape(np.shape(x)))

    def slope(self, x: Array) -> Array:
        """s'(x), shape of x."""
        return self._at(self.series, x)

    def slip(self, x: Array) -> Array:
        """s(x), shape of x."""
        return self._at(self._rise, x)

    def within(self, b1: float, b2: float) -> Frozen:
        """Without the pieces outside [b1, b2]."""
        tiny = 1e-11 * (b2 - b1)
        kept = np.flatnonzero((self.ends[1:] > b1 + tiny) & (self.low < b2 - tiny))
        if len(kept) == len(self.low):
            return self
        first, last, slip = kept[0], kept[-1] + 1, float(self.slip(np.array([b1]))[0])
        return Frozen(self.ends[first : last + 1], self.series[:, first:last], b1, slip)

    def joined(self, side: int, edge: float, slope: Array, end: float) -> Frozen:
        """With one more piece at a side, from the stick edge to `end`: s' = `slope` (n + 1,) at its `_places`, left to right."""
        n, ends, series = len(slope) - 1, self.ends, np.pad(self.series, ((0, max(len(slope) - len(self.series), 0)), (0, 0)))
        known = float(self.slip(np.array([edge]))[0])
        if side > 0:
            last = int(np.clip(np.searchsorted(ends, edge) - 1, 0, len(self.low) - 1))
            cut, kept, far = (float(ends[last]), edge), series[:, :last], ends[: last + 1]
        else:
            last = int(np.clip(np.searchsorted(ends, edge, side="right") - 1, 0, len(self.low) - 1))
            cut, kept, far = (edge, float(ends[last + 1])), series[:, last + 1 :], ends[last + 1 :]
        rows = [_fit(self.slope(_places(*cut, n))), _fit(slope)]
        new = Frozen(np.array([cut[0], edge, end] if side > 0 else [end, edge, cut[1]]), np.stack(rows[::side], axis=1))
        parts = (far[:-1], new.ends) if side > 0 else (new.ends, far[1:])
        return Frozen(np.concatenate(parts), np.concatenate([kept, new.series][::side], axis=1), edge, known)

    def _rule(self, number: NDArray[np.intp], begin: Array, end: Array, shares: tuple[Array, Array, Array]) -> Array:
        """Weight, s' and distances from both ends at nodes of parts of pieces, theta from `begin` to `end` (k,): (4, k, m)."""
        (share, rest, weights), begin, span = shares, begin[:, None], (end - begin)[:, None]
        theta = np.where(share < 0.5, begin + span * share, end[:, None] - span * rest)
        length, numbers, at = self.length[number][:, None], np.repeat(number[:, None], len(share), axis=1), 2 * theta / np.pi - 1
        up = length * np.sin((theta + begin) / 2) * np.sin(span * share / 2)
        down = length * np.sin((theta + end[:, None]) / 2) * np.sin(span * rest / 2)
        weight = span * weights * length / 2 * np.sin(theta)
        return np.stack([weight, clenshaw(self.series, numbers, at), up, down])

    def quadrature(self, b1: Array, b2: Array) -> Quadrature:
        """Nodes of [b1, b2] (n,), piece by piece, with distances from both edges that do not cancel.

        Of a piece as far from both edges as it is long Gauss' nodes in theta, of others the graded ones.
        """
        k, p = np.nonzero(np.minimum(b2[:, None], self.ends[1:]) > np.maximum(b1[:, None], self.low))
        low, high = np.maximum(b1[k], self.low[p]), np.minimum(b2[k], self.ends[p + 1])
        far, found = np.minimum(low - b1[k], b2[k] - high) > high - low, []
        for some, plain in ((np.flatnonzero(far), True), (np.flatnonzero(~far), False)):
            if len(some):
                row, piece = k[some], p[some]
                # Of a piece that is not cut the ends are those of theta, to the last digit.
                begin = np.where(b1[row] > self.low[piece], self._theta(piece, low[some]), 0.0)
                end = np.where(b2[row] < self.ends[piece + 1], self._theta(piece, high[some]), np.pi)
                weight, slope, up, down = self._whole[:, piece] if plain else self._rule(piece, begin, end, _GRADED)
                left, right = (low[some] - b1[row])[:, None], (b2[row] - high[some])[:, None]
                rows = np.repeat(row[:, None], weight.shape[1], axis=1)
                found.append([rows, low[some, None] + up, weight, slope, up + left, down + right])
        if not found:
            raise NotOneStickInterval("load: the bulk stress leaves no stick zone whose edges could be followed")
        row, *parts = (np.concatenate([each.ravel() for each in part]) for part in zip(*found, strict=True))
        order = np.argsort(row, kind="stable")
        return Quadrature(row[order], *(part[order] for part in parts))

    def moments(self, b1: Array, b2: Array, *, slip: bool = False) -> Array:
        """int s'/w, int zeta s'/w and, where asked for, int zeta^2 s'/w and int s/w over [b1, b2] (n,): (2 or 4, n)."""
        each = self.quadrature(b1, b2)
        w, zeta = each.weight / np.sqrt(each.up * each.down), (each.up - each.down) / 2
        wanted = [each.slope, zeta * each.slope] + ([zeta**2 * each.slope, self.slip(each.x)] if slip else [])
        return np.array([np.bincount(each.row, w * values, len(b1)) for values in wanted])


# ---------------------------------------------------------------------------------------------------------- the contact
@dataclass(frozen=True)
class Parabola:
    """Frictionless contact of h = x^2/(2 R) under P and tilt: middle -alpha R, half-length sqrt(2 A R P/pi) (Hertz)."""

    compliance: float
    radius: float

    def edges(self, load: Array, tilt: Array) -> Array:
        """a1 and a2, (2, n)."""
        middle, half = -tilt * self.radius, np.sqrt(2 * self.compliance * self.radius * load / np.pi)
        return np.stack([middle - half, middle + half])


@dataclass(frozen=True, eq=False)
class Stick:
    """One stick interval at n instants.

    Attributes
    ----------
    slips : direction of slip at the left and at the right end: 0 where stick goes up to the edge of contact
    loads, rates : (4, n) P, Q, eps, alpha and their derivatives in time
    edges : (2, n) b1, b2
    """

    contact: Parabola
    friction: float
    frozen: Frozen
    slips: tuple[int, int]
    loads: Array
    rates: Array
    edges: Array

    @cached_property
    def contact_edges(self) -> Array:
        """a1 and a2, (2, n)."""
        return self.contact.edges(self.loads[0], self.loads[3])

    @property
    def opposite(self) -> bool:
        """Whether both ends slip, in opposite directions."""
        return self.slips[0] * self.slips[1] < 0

    @property
    def middle(self) -> Array:
        """m, (n,)."""
        return np.asarray(np.sum(self.edges, axis=0) / 2)

    @property
    def half(self) -> Array:
        """c, (n,)."""
        return np.asarray(np.diff(self.edges, axis=0)[0] / 2)

    @property
    def width(self) -> float:
        """Of the contact at first."""
        return float(self.contact_edges[1, 0] - self.contact_edges[0, 0])

    def part(self, first: int, last: int | None = None) -> Stick:
        """Some of the instants."""
        loads, rates, edges = (each[:, first:last] for each in (self.loads, self.rates, self.edges))
        return replace(self, loads=loads, rates=rates, edges=edges)

    def direction(self, side: int) -> int:
        """d of a side: that of the other end where it sticks, 1 where both do."""
        first, second = self.slips[::side]
        return second or first or 1

    def zone(self, side: int) -> tuple[Array, Array]:
        """Nodes and weights (n, m) of the slip zone of a side, for roots at both of its ends."""
        i = (side + 1) // 2
        low, high = np.sort([self.edges[i], self.contact_edges[i]], axis=0)
        half = ((high - low) / 2)[:, None]
        return (low + high)[:, None] / 2 - half * np.cos(_ANGLE), half * np.sin(_ANGLE) * _ANGLE_WEIGHT

    def pressure(self, x: Array) -> Array:
        """p at x (n, m), 0 outside."""
        a1, a2 = self.contact_edges[..., None]
        return np.asarray(np.sqrt(np.maximum((x - a1) * (a2 - x), 0.0)) / (self.contact.compliance * self.contact.radius))

    def pressure_rate(self, x: Array) -> Array:
        """dp/dt at x (n, m) in the contact."""
        a1, a2 = self.contact_edges[..., None]
        turning = self.rates[3][:, None] / self.contact.compliance * (x - (a1 + a2) / 2)
        root = np.sqrt(np.maximum((x - a1) * (a2 - x), np.finfo(float).tiny))
        return np.asarray((self.rates[0][:, None] / np.pi - turning) / root)

    def _driven(self, side: int, loads: Array, pressure: Callable[[Array], Array]) -> Array:
        """K without what h' and s' make of it, (n,); p by `pressure`."""
        (P, Q, eps, alpha), f, d = loads, self.friction, self.direction(side)
        load = f * P - d * Q - side * np.pi * self.half / self.contact.compliance * (f * alpha - d * eps)
        if self.opposite:
            x, weight = self.zone(-side)
            own, other = self.edges[::-side, :, None]
            load = load - 2 * f * np.sum(weight * pressure(x) * np.sqrt((x - other) / (x - own)), axis=1)
        return np.asarray(load)

    def edge_load(self, side: int) -> Array:
        """K of the rates at the stick edge of a side, (n,): negative while the edge recedes."""
        return self._driven(side, self.rates, self.pressure_rate)

    def excess(self) -> Array:
        """A K of the loads at both edges, (2, n): 0 at the edges of stick."""
        f, A, c = self.friction, self.contact.compliance, self.half
        g0, g1 = self.frozen.moments(*self.edges)
        h0, h1 = np.pi * self.middle / self.contact.radius, np.pi * c**2 / 2 / self.contact.radius
        found = []
        for _, side in _SIDES:
            d = self.direction(side)
            total = f * (h1 + side * c * h0) - d * (g1 + side * c * g0)
            found.append(A * self._driven(side, self.loads, self.pressure) - total)
        return np.array(found)

    def excess_rates(self, found: Array, moves: Sequence[int]) -> Array:
        """Derivatives of `excess`, whose value is `found`, by the edges that move, towards the middle: (n, k, k)."""
        columns, step = [], 1e-8 * self.width
        for i in moves:
            shifted = self.edges.copy()
            shifted[i] += (1 - 2 * i) * step
            columns.append((replace(self, edges=shifted).excess() - found)[list(moves)] / ((1 - 2 * i) * step))
        return np.array(columns).transpose(2, 1, 0)

    def at_contact_edge(self, side: int) -> tuple[Array, Array]:
        """Strengths of q' and of f p' at a contact edge that sticks, (n,) each."""
        a1, a2 = self.contact_edges
        c, d = (a2 - a1) / 2, self.direction(side)
        pressure = self.friction * (self.rates[0] - side * np.pi * c / self.contact.compliance * self.rates[3]) / np.sqrt(2 * c)
        return d * (pressure - self.edge_load(side) / np.sqrt(2 * self.half)), pressure

    def slip_rate(self, side: int, x: Array) -> Array:
        """d ds/dt at x (n, m) in the slip zone of a side: positive."""
        (P, Q, eps, alpha), f, A, d = self.rates[..., None], self.friction, self.contact.compliance, self.direction(side)
        c = self.half[:, None]
        zeta = side * (x - self.middle[:, None])
        past = np.maximum(side * (x - self.edges[(side + 1) // 2][:, None]), 0.0)
        w = np.sqrt(past * (past + 2 * c))
        rate = side * (f * alpha - d * eps) * w - A / np.pi * (f * P - d * Q) * np.arctanh(w / zeta)
        if self.opposite:
            xi, weight = self.zone(-side)
            there, here = (side * (xi - self.middle[:, None]))[:, None, :], zeta[:, :, None]
            ratio = (c[:, :, None] ** 2 - there * here) / (c[:, :, None] * (here - there))
            p = weight * self.pressure_rate(xi)
            rate = rate + 2 * A / np.pi * f * np.einsum("kj,kij->ki", p, np.arccosh(np.maximum(ratio, 1.0)))
        return np.asarray(rate)

    def outer_slope_rate(self, side: int, x: Array) -> Array:
        """ds'/dt at x (n, m) outside the contact, beyond a side that sticks up to its edge."""
        (P, Q, eps, alpha), f, A, d = self.rates[..., None], self.friction, self.contact.compliance, self.direction(side)

        def root(edges: Array, load: Array, turn: Array) -> Array:
            low, high = edges[..., None]
            # Next to the edge the product is rounding, and may be negative.
            w = np.sqrt(np.maximum((x - low) * (x - high), 1e-15 * (high - low) ** 2))
            return np.asarray((A / np.pi * load * side - side * turn * (x - (low + high) / 2)) / w)

        return d * (f * root(self.contact_edges, P, alpha) - root(self.edges, f * P - d * Q, f * alpha - d * eps))

    def _drive(self, x: Array, slope: Array, d: int, rows: NDArray[np.intp] | slice = slice(None)) -> Array:
        """F at x (n, m), where the frozen s' is `slope`."""
        loads = self.loads[:, rows, None]
        return np.asarray(self.friction * (x / self.contact.radius + loads[3]) - d * (slope + loads[2]))

    def _means(self, x: Array, datum: Array, d: int) -> Array:
        """int [F(y) - F_0]/[w(y) (y - x)] dy over stick, at x and with F_0 = `datum` (n, m)."""
        each = self.frozen.quadrature(*self.edges)
        rows = each.row
        inverse = each.x[:, None] - x[rows]
        np.divide(1.0, inverse, out=inverse, where=inverse != 0)
        inverse *= (self._drive(each.x[:, None], each.slope[:, None], d, rows) - datum[rows]) * (
            each.weight / np.sqrt(each.up * each.down)
        )[:, None]
        return each.summed(inverse)

    def _far_zone(self, side: int, x: Array) -> Array:
        """int p/[sqrt((xi - b1) (xi - b2)) (x - xi)] d xi over the slip zone of a side, at x (n, m)."""
        xi, weight = self.zone(side)
        p = weight * self.pressure(xi) / _root_beyond(xi - self.middle[:, None], self.half[:, None])
        return np.sum(p[:, None, :] / (x[:, :, None] - xi[:, None, :]), axis=2)

    def shear_reserve(self, x: Array) -> Array:
        """q*/w at x (n, m) within the stick interval: q = d (f p - q*) with d of the right side."""
        d = self.direction(1)
        total = self._means(x, self._drive(x, self.frozen.slope(x), d), d) / (np.pi * self.contact.compliance)
        return np.asarray(total + 2 * self.friction / np.pi * self._far_zone(-1, x) if self.opposite else total)

    def outer_slope(self, side: int, x: Array) -> Array:
        """s' at x (n, m) beyond the stick edge of a side, in the slip zone and outside the contact."""
        (b1, b2), f, A, d = self.edges[..., None], self.friction, self.contact.compliance, self.direction(side)
        edge = b2 if side > 0 else b1
        at_edge = self._drive(edge, self.frozen.slope(edge), d)
        root = side * np.sqrt(np.maximum((x - b1) * (x - b2), 0.0))
        total = -self._means(x, at_edge + 0 * x, d)
        if self.opposite:
            total = total - 2 * A * f * side * self._far_zone(-side, x)
        zeta, half = x - np.mean(self.contact_edges, axis=0)[:, None], (np.diff(self.contact_edges, axis=0)[0] / 2)[:, None]
        # (A/pi) H p is h' + alpha in the contact, and this outside.
        beyond = (zeta - np.sign(zeta) * np.sqrt(np.maximum(zeta**2 - half**2, 0.0))) / self.contact.radius
        return np.asarray(d * (f * beyond - at_edge - root / np.pi * total) - self.loads[2][:, None])

    def displacement(self) -> tuple[Array, Array]:
        """U and m_q, (n,) each: from the means of the equations of stick over 1/w."""
        (_, Q, eps, _), A, m, c = self.loads, self.contact.compliance, self.middle, self.half
        _, _, second, slip = self.frozen.moments(*self.edges, slip=True)
        U = slip / np.pi + eps * m - A / np.pi * Q * np.log(c / 2)
        moment = m * Q + (second + eps * np.pi * c**2 / 2) / A
        for i, side in _SIDES:
            if self.slips[i]:
                x, weight = self.zone(side)
                zeta, q = x - m[:, None], self.slips[i] * self.friction * weight * self.pressure(x)
                U = U - A / np.pi * np.sum(q * np.arccosh(np.maximum(np.abs(zeta) / c[:, None], 1.0)), axis=1)
                moment = moment + side * np.sum(q * zeta**2 / _root_beyond(np.abs(zeta), c[:, None]), axis=1)
        return U, moment

    def shear_energy(self, order: int) -> float:
        """Elastic energy of q at the last instant, (Q U - m_q eps - int q s)/2; q has roots at edges, logarithms at old ones."""
        last, (nodes, weights) = self.part(-1), np.polynomial.legendre.leggauss(40)  # none of them is one of `quadrature`
        contact = last.contact_edges[:, 0]
        marks = np.concatenate([last.edges[:, 0], contact, self.frozen.ends, contact[0] + np.ptp(contact) * np.arange(1, 30) / 30])
        marks = np.unique(np.clip(marks, *contact))
        angle, length = np.pi * (1 + nodes) / 2, np.diff(marks)[:, None]
        x, weight = marks[:-1, None] + length * np.sin(angle / 2) ** 2, length * np.pi / 4 * weights * np.sin(angle)
        _, q, s, _ = last.fields(x.ravel(), order)[:, 0]
        (U, moment), (_, Q, eps, _) = (float(each[0]) for each in last.displacement()), last.loads[:, 0]
        return float(Q * U - moment * eps - np.sum(weight.ravel() * q * s)) / 2

    def fields(self, x: Array, order: int) -> Array:
        """p, q, s and the state of the surface at points (m,): (4, n, m)."""
        (a1, a2), (b1, b2), f = self.contact_edges[..., None], self.edges[..., None], self.friction
        p, touching, sticks = self.pressure(x), (x >= a1) & (x <= a2), (x >= b1) & (x <= b2)
        q = f * p * np.where(x > b2, self.slips[1], self.slips[0])
        state = np.where(sticks, STICK, np.where(touching, np.where(q > 0, SLIP_FORWARD, SLIP_REVERSE), OPEN))
        here = np.where(sticks, x, (b1 + b2) / 2)
        reserve = self.shear_reserve(here) * np.sqrt((here - b1) * (b2 - here))
        q, s = np.where(sticks, self.direction(1) * (f * p - reserve), q), self.frozen.slip(here)
        for side, begin, middle in ((-1, b1, a1), (1, b2, a2)):
            far = np.maximum(middle, np.max(x)) if side > 0 else np.minimum(middle, np.min(x))
            at_begin, share = self.frozen.slip(begin), (_nodes(order) + 1) / 2
            for first, last in ((begin, middle), (middle, far)):
                way = last - first
                slope = np.zeros((len(way), order + 1))  # not used where the way begins: x stands still there
                slope[:, 1:] = self.outer_slope(side, first + way * share[1:] ** 2)
                rise = _primitive(_fit(np.where(side * way > 1e-12 * self.half[:, None], slope * share * way, 0.0).T))[..., None]
                passed = np.clip((x - first) / np.where(way != 0, way, 1.0), 0, 1)
                between = (side * (x - first) > 0) & (side * (x - last) <= 0)
                s = np.where(between, at_begin + chebyshev.chebval(2 * np.sqrt(passed) - 1, rise, tensor=False), s)
                at_begin = at_begin + chebyshev.chebval(np.ones(1), rise, tensor=False)
        return np.stack([p, np.where(touching, q, 0.0), s, state])


@dataclass(frozen=True, eq=False)
class State:
    """An instant: both edges of stick, direction of slip at either end (0: stick up to the edge of contact), the frozen s'."""

    time: float
    edges: tuple[float, float]
    slips: tuple[int, int]
    frozen: Frozen

    def closed(self, side: int, edge: float, frozen: Frozen | None = None) -> State:
        """With the stick edge of a side at the edge of contact."""
        (b1, b2), (left, right) = self.edges, self.slips
        edges, slips = ((b1, edge), (left, 0)) if side > 0 else ((edge, b2), (0, right))
        return replace(self, edges=edges, slips=slips, frozen=frozen or self.frozen)


@dataclass(frozen=True, eq=False)
class Step:
    """A stretch of time without events: `stick` at nodes 0..n of phi, with time = begin + duration sin(pi (1 + phi)/4)^2.

    `work` is the friction work, `wrong` the largest share of slip rate or f p0 that breaks a law of friction, at x = `where`.
    """

    time: Array
    stick: Stick
    work: float = 0.0
    wrong: float = 0.0
    where: float = 0.0

    @property
    def time_rate(self) -> Array:
        """d time/d phi at the nodes."""
        return np.asarray(np.cos(np.pi * _nodes(len(self.time) - 1) / 2) * np.pi / 4 * (self.time[-1] - self.time[0]))

    def at(self, time: Array, loads: Loads | PathLoads) -> Stick:
        """Stick at any instants of the step, (n,)."""
        inside = np.clip(time, self.time[0], self.time[-1])
        phi = 4 / np.pi * np.arcsin(np.sqrt((inside - self.time[0]) / (self.time[-1] - self.time[0]))) - 1
        given = loads.values(inside)
        found = replace(self.stick, loads=given, rates=loads.rates(inside), edges=_value(phi, _fit(self.stick.edges.T)))
        a1, a2 = found.contact_edges
        b1 = np.maximum(found.edges[0], a1) if found.slips[0] else a1
        return replace(found, edges=np.stack([b1, np.minimum(found.edges[1], a2) if found.slips[1] else a2]))


@dataclass
class Follower:
    """Steps from state to state.

    Attributes
    ----------
    contact : the frictionless contact
    friction : f
    loads : P, Q, eps and alpha of time
    longest : longest step
    order : degree in time of a step
    fastest : largest slip rate so far
    counts : steps, tries, iterations of Newton's method, jumps of edges, stretches bridged
    """

    contact: Parabola
    friction: float
    loads: Loads
    longest: float
    order: int = ORDER
    fastest: float = np.finfo(float).tiny
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(("steps", "tries", "iterations", "jumps", "bridged"), 0))

    def _stick(self, state: State, slips: tuple[int, int], time: Array, late: float = 0.0) -> Stick:
        """A state's edges at several instants; rates `late` after them."""
        edges = np.repeat(np.array(state.edges)[:, None], len(time), axis=1)
        loads, rates = self.loads.values(time), self.loads.rates(time + late)
        return Stick(self.contact, self.friction, state.frozen, slips, loads, rates, edges)

    def _grown(self, frozen: Frozen, stick: Stick, duration: float, side: int, phi: Array, x: Array, slope: Array) -> Frozen:
        """`frozen` with the s' that a contact edge meets at x, at the places `phi` of the step, while it advances in stick.

        `slope` is what s' is there at first.
        """
        i = (side + 1) // 2
        # Nothing is singular at either end of the time in v.
        v, late = (1 + _NODES) / 2, 1 + phi[:, None]
        at, weight = late * (1 - v * v) - 1, late * v * _WEIGHTS * duration * np.pi / 4
        found = _value(at.ravel(), _fit(np.concatenate([stick.rates, stick.loads, stick.edges]).T))
        there = replace(stick, rates=found[:4], loads=found[4:8], edges=found[8:])
        there.edges[i] = there.contact_edges[i]
        rate = there.outer_slope_rate(side, np.repeat(x, len(v))[:, None]).reshape(at.shape)
        slope = slope + np.sum(weight * np.sin(np.pi * (1 + at) / 2) * rate, axis=1)
        first, last = x[::side][[0, -1]].tolist()
        return frozen.joined(side, first, slope, last)

    def _attempt(self, state: State, slips: tuple[int, int], end: float) -> Step | None:
        """The step up to `end`, by Newton's method; None where that does not converge."""
        self.counts["tries"] += 1
        time = _times(state.time, end, self.order)
        stick = self._stick(state, slips, time)
        a, edges, share, size = stick.contact_edges, stick.edges, (time - time[0]) / (end - time[0]), stick.width
        limits, grown, moves = np.zeros((2, 1)), {}, [i for i, _ in _SIDES if slips[i]]
        for i, side in _SIDES:
            # First guesses. Where a contact edge has just stopped to stick, q* has no root there yet, and the stick edge returns at
            # about the speed that the contact edge has. Where the contact recedes, the slip zone is about as wide as it was.
            if slips[i]:
                back = 0.0 if state.slips[i] else np.maximum(side * (a[i] - a[i, 0]), 0.0)
                zone = 0.98 * min(abs(state.edges[i] - a[i, 0]), 1e-2 * size) + 1e-5 * share * size
                edges[i, 1:] = side * np.minimum(side * state.edges[i] - back, side * a[i] - zone)[1:]
                limits[i] = side * min(side * float(state.frozen.ends[-i]), side * state.edges[i])
                continue
            edges[i] = a[i]
            if side * (a[i, -1] - a[i, 0]) > 1e-11 * size:
                x, series = _places(float(a[i, i - 1]), float(a[i, -i]), 2 * self.order), _fit(a[i])
                met = [
                    scipy.optimize.brentq(lambda phi, to=to, of=series: float(_value(phi, of)) - to, -1, 1, xtol=1e-15)
                    for to in x[1:-1]
                ]
                outside = self._stick(state, state.slips, time[:1]).outer_slope(side, x[None])[0]
                grown[side] = np.array([-side, *met, side]), x, outside
        # What the step before has left fades over this one: a jump would make s' singular.
        left_over = stick.part(0, 1).excess()[moves] * (1 - share[1:])
        last, held = math.inf, True
        before, moved, matrix = np.zeros((3, 1, 1))
        for iteration in range(25):
            self.counts["iterations"] += 1
            frozen = state.frozen
            for side, known in grown.items():
                frozen = self._grown(frozen, stick, end - time[0], side, *known)
            stick = replace(stick, frozen=frozen)
            if not moves:
                return Step(time, stick)
            later = stick.part(1)
            every = later.excess()
            found = every[moves] - left_over
            if held:
                matrix = later.excess_rates(every, moves)
            else:  # Broyden's update of the matrix of every instant
                norm = np.sum(moved**2, axis=0)
                missed = (found - before).T - np.einsum("nij,jn->ni", matrix, moved)
                update = missed[:, :, None] * moved.T[:, None] / np.maximum(norm, 1e-300)[:, None, None]
                matrix = matrix + np.where((norm > (1e-9 * size) ** 2)[:, None, None], update, 0.0)
            if not np.all(np.isfinite(found)) or not np.all(np.isfinite(matrix)) or np.any(np.linalg.det(matrix) == 0):
                return None
            change, before, old = -np.linalg.solve(matrix, found.T[..., None])[..., 0].T, found, edges.copy()
            edges[moves, 1:] += change
            edges[0, 1:] = np.maximum(edges[0, 1:], np.maximum(a[0, 1:], limits[0])) if slips[0] else a[0, 1:]
            edges[1, 1:] = np.minimum(edges[1, 1:], np.minimum(a[1, 1:], limits[1])) if slips[1] else a[1, 1:]
            edges[:] = np.where(edges[1] <= edges[0], (3 * old + old[::-1]) / 4, edges)
            moved = (edges - old)[moves, 1:]
            largest, held = float(np.max(np.abs(moved))), bool(np.max(np.abs(moved - change)) > 1e-9 * size)
            if (iteration > 7 and largest > 1e-3 * size) or (held and iteration > 12):
                return None
            if not held and (largest < 1e-12 * size or (iteration > 4 and last / 4 < largest < 1e-9 * size)):
                return Step(time, stick)
            last = largest
        return None

    def _passage(self, state: State, step: Step) -> float | None:
        """The time at which a stick edge of a step comes to the first old one, to a share of the contact; None if none does.

        Beyond the old edge s' has another series: a step that goes a little too far is not smooth, and has no part in the answer.
        """
        stick, size, found = step.stick, step.stick.width, []
        for i, side in _SIDES:
            edge, marks = side * stick.edges[i], side * state.frozen.ends[1:-1]
            marks = marks[(marks < edge[0] - 3e-7 * size) & (marks > np.min(edge))]
            if not stick.slips[i] or not len(marks):
                continue
            mark = float(np.max(marks)) + _GAP * size
            k = int(np.flatnonzero(edge < mark)[0])
            share = float((edge[k - 1] - mark) / (edge[k - 1] - edge[k]))
            low, high = step.time[k - 1 : k + 1].tolist()
            time, others, free = low + share * (high - low), stick.edges[1 - i, k - 1 : k + 1], stick.slips[1 - i] != 0
            other, change = float(others[0] + share * (others[1] - others[0])), math.inf
            for _ in range(30):
                width = np.array([1e-6 * (high - low), -side * 1e-8 * size])
                times = np.array([time, time + width[0], time])
                if not free:
                    other = float(self.contact.edges(*self.loads.values(times[:1])[[0, 3]])[1 - i, 0])
                edges = np.array([[side * mark] * 3, [other, other, other + width[1]]])[::-side]
                residual = replace(stick, loads=self.loads.values(times), rates=stick.rates[:, :3], edges=edges).excess()
                rates = (residual[:, 1:] - residual[:, :1]) / width
                full = np.array([-residual[i, 0] / rates[i, 0], 0.0])
                if free:
                    full = -np.linalg.lstsq(np.nan_to_num(rates), np.nan_to_num(residual[:, 0]), rcond=None)[0]
                new = min(max(time + float(full[0]), (low + time) / 2), (high + time) / 2)
                change, time, other = abs(new - time), new, other + float(full[1])
                if change < 1e-13 * (high - low):
                    break
            found.append(time)
        return min(found, default=None)

    def _first_event(self, step: Step) -> tuple[float, str, int] | None:
        """Time, name and side of the first event of a step."""
        stick, found, nodes = step.stick, list[tuple[float, str, int]](), _nodes(self.order)
        for i, side in _SIDES:
            if stick.slips[i]:
                monitors = {"turn": -stick.edge_load(side), "gone": side * (stick.contact_edges[i] - stick.edges[i])}
            else:
                shear, limit = stick.at_contact_edge(side)
                monitors = {"forward": limit - shear, "reverse": limit + shear}
            for name, values in monitors.items():
                below = np.flatnonzero(values[1:] < -1e-11 * np.max(np.abs(values)))
                if len(below):
                    low, high, series = float(nodes[below[0]]), float(nodes[below[0] + 1]), _fit(values)
                    ends = float(_value(low, series)), float(_value(high, series))
                    root = scipy.optimize.brentq(_value, low, high, args=(series,), xtol=1e-14) if ends[0] > 0 > ends[1] else low
                    share = math.sin(math.pi * (root + 1) / 4) ** 2
                    found.append((float(step.time[0] + (step.time[-1] - step.time[0]) * share), name, side))
        return min(found, default=None)

    def _to_event(self, state: State, slips: tuple[int, int], until: float) -> tuple[Step, tuple[float, str, int] | None] | None:
        """The step up to `until`, or to the first event before, with that event; None where it is not found."""
        event = None
        for _ in range(6):
            step = self._attempt(state, slips, until)
            if step is None:
                return None
            passed = self._passage(state, step)
            if passed is None:
                found = self._first_event(step)
                if found is None or found[0] > until - 1e-11 * self.longest:
                    return step, found or event
                event, passed = found, found[0]
            until = max(passed, state.time + 1e-9 * self.longest)
        return None

    # ------------------------------------------------------------------------------------------------ from step to step
    def touch(self, begin: float, end: float) -> tuple[Step, State]:
        """The first step, from the first touch at `begin`: on a straight line of all loads, as long as all sticks.

        With the root u of the share of time the edges are start +- C u - D u^2, and what they freeze at x is

            s' = int side [(A/pi) Q' - eps' (x - m)]/sqrt((x - m)^2 - c^2) dt    up to the u at which they are there
        """
        A, R, middle = self.contact.compliance, self.contact.radius, np.array([(begin + end) / 2])
        (P, Q, eps, alpha), tilt = self.loads.rates(middle)[:, 0], self.loads.values(middle)[3, 0]
        start = -R * (tilt - alpha * (middle[0] - begin))
        # Where slip begins at an edge: |Q' -+ (pi c/A) eps'| = f (P' -+ (pi c/A) alpha').
        ways = np.array([(side, d) for _, side in _SIDES for d in (-1, 1)]).T
        with np.errstate(divide="ignore", invalid="ignore"):
            halves = ways[0] * A / np.pi * (self.friction * P - ways[1] * Q) / (self.friction * alpha - ways[1] * eps)
        reach = np.min(halves, where=halves > 0, initial=np.inf)
        end = min(end, begin + np.pi * reach**2 / (2 * A * R * P) * (1 + 1e-12))
        C, D = math.sqrt(2 * A * R * P * (end - begin) / np.pi), R * alpha * (end - begin)
        a1, a2 = start - C - D, start + C - D
        x = _places(a1, a2, 2 * self.order)[:, None]
        y, side = x - start, np.where(x > start, 1.0, -1.0)
        reached = np.maximum(2 * np.abs(y) / (C + np.sqrt(np.maximum(C * C - 4 * D * y, 0.0))), 1e-100)
        # u = u_x (1 - v^2): nothing is singular at either end in v.
        v = (1 + _NODES) / 2
        u = reached * (1 - v * v)
        near, far = C - side * D * (reached + u), np.abs(y) + C * u + side * D * u**2
        rate = side * (A / np.pi * Q - eps * (y + D * u**2)) / np.sqrt(reached * near * far)
        frozen = Frozen(np.array([a1, a2]), _fit(np.sum(_WEIGHTS * 2 * (end - begin) * u * reached * rate, axis=1))[:, None])
        time = _times(begin + 1e-6 * (end - begin), end, self.order)
        stick = self._stick(State(end, (a1, a2), (0, 0), frozen), (0, 0), time)
        return self._finished(Step(time, replace(stick, edges=stick.contact_edges)))

    def _finished(self, step: Step) -> tuple[Step, State]:
        """The step with its work and its breaches of the laws, and the state at its end."""
        self.counts["steps"] += 1
        stick, work = step.stick, 0.0
        b1, b2 = stick.edges[:, -1].tolist()
        wrongs = [(0.0, b1)]
        for i, side in _SIDES:
            if stick.slips[i]:
                x, weight = stick.zone(side)
                rate = stick.slip_rate(side, x)
                work += _integral(self.friction * np.sum(weight * stick.pressure(x) * rate, axis=1) * step.time_rate)
                self.fastest = max(self.fastest, float(np.max(rate)))
                wrongs.append((-float(np.min(rate)) / self.fastest, float(x.flat[np.argmin(rate)])))
        x, last = b1 + (b2 - b1) * np.linspace(0.01, 0.99, 40), stick.part(-1)
        reserve = last.shear_reserve(x[None])[0] * np.sqrt((x - b1) * (b2 - x))
        limit = 2 * self.friction * last.pressure(x[None])[0]
        beyond = np.maximum(-reserve, reserve - limit)
        wrongs.append((float(np.max(beyond) / np.max(limit)) * 2, float(x[np.argmax(beyond)])))
        wrong, where = max(wrongs)
        frozen = stick.frozen.within(b1, b2)
        # A sliver without s' of a share t of the stick interval would cost the root of t.
        edges = max(b1, float(frozen.ends[0])), min(b2, float(frozen.ends[-1]))
        state = State(float(step.time[-1]), edges, stick.slips, frozen)
        return replace(step, work=work, wrong=wrong, where=where), state

    def _closed(self, state: State, side: int, now: Stick) -> State:
        """The state whose slip zone of a side has come to rest: its s' is frozen up to the edge of contact."""
        edge, end = state.edges[(side + 1) // 2], float(now.contact_edges[(side + 1) // 2, 0])
        # A loop that closes brings the edge back to an old one.
        old = state.frozen.ends[1:-1]
        near = old[np.abs(old - edge) < 1e-8 * (state.edges[1] - state.edges[0])]
        edge = float(near[0]) if len(near) else edge
        x = _places(min(edge, end), max(edge, end), 2 * self.order)
        edges = (state.edges[0], edge) if side > 0 else (edge, state.edges[1])
        slope = replace(now, edges=np.array(edges)[:, None]).outer_slope(side, x[None])[0]
        return state.closed(side, end, state.frozen.joined(side, edge, slope, end))

    def _next_slips(self, state: State, turned: set[int]) -> tuple[State, tuple[int, int]]:
        """What both ends do just after an instant; slip zones that come to rest are closed. `turned`: sides of a turning point."""
        time = np.array([state.time])
        for _ in range(3):
            closed = False
            for i, side in _SIDES:
                now = self._stick(state, state.slips, time, _SOON * self.longest)
                if not state.slips[i] or (side not in turned and float(now.edge_load(side)[0]) < 0):
                    continue
                if float(now.slip_rate(side, now.contact_edges[i][:, None])[0, 0]) > 0:
                    raise _broken(state.time, state.edges[i], "a stick edge advances into a zone that slips on")
                state, closed = self._closed(state, side, now), True
            if not closed:
                break
        slips, now = [0, 0], self._stick(state, state.slips, time, _SOON * self.longest)
        for i, side in _SIDES:
            if state.slips[i]:
                slips[i] = state.slips[i]
                continue
            shear, limit = (float(v[0]) for v in now.at_contact_edge(side))
            if limit >= 0:
                slips[i] = 0 if abs(shear) <= limit else int(math.copysign(1, shear))
                continue
            # The contact recedes: slip goes to where q' is beyond what q/p at the edge would make of p'.
            (a1, a2), d = now.contact_edges[:, 0], now.direction(side)
            reserve = float(now.shear_reserve(now.contact_edges[i][:, None])[0, 0]) * math.sqrt(state.edges[1] - state.edges[0])
            pressure = math.sqrt(a2 - a1) / (self.contact.compliance * self.contact.radius)
            slips[i] = 1 if shear > d * (1 - reserve / (self.friction * pressure)) * limit else -1
        return state, (slips[0], slips[1])

    def _turn(self, state: State, slips: tuple[int, int], stop: float) -> float:
        """When the loads turn round for one of the edges, held where they are: `stop` if they do not soon."""
        time = np.linspace(state.time, min(stop, state.time + self.longest / 16), 33)
        now = self._stick(state, slips, time)
        most = np.max([now.edge_load(side) for _, side in _SIDES], axis=0)
        turned = np.flatnonzero((most[1:] >= 0) & (most[:-1] < 0))
        if not len(turned):
            return stop
        k = int(turned[0])
        return float(time[k] + (time[k + 1] - time[k]) * most[k] / (most[k] - most[k + 1]))

    def _held(self, state: State, slips: tuple[int, int], end: float) -> tuple[Step, State]:
        """A short step with edges held, up to a turning point or over a jump."""
        time = _times(state.time, end, self.order)
        return self._finished(Step(time, self._stick(state, slips, time)))

    def _jump(self, state: State, slips: tuple[int, int], stop: float) -> tuple[Step, State] | None:
        """A step over the instant at which edges leave a stretch without q*, which a loop that closes has left; None for none."""
        (b1, b2), old, size = state.edges, state.frozen.ends[1:-1], state.edges[1] - state.edges[0]
        pairs = sorted(((right - left, left, right) for left in (b1, *old) for right in (*old, b2) if left < right), reverse=True)
        start = np.array(pairs[:40]).T[1:] + 1e-4 * size * np.array([[1], [-1]])
        for time in state.time + self.longest * 10.0 ** np.arange(-9, -2):
            if time >= stop:
                return None
            stick = replace(self._stick(state, slips, np.full(len(start[0]), time)), edges=start)
            found = change = start
            for _ in range(20):
                found = stick.excess()
                rates = np.nan_to_num(stick.excess_rates(found, (0, 1)))
                change = -np.einsum("nij,jn->in", np.linalg.pinv(rates), np.nan_to_num(found))
                new = np.clip(stick.edges + np.clip(change, -0.1 * size, 0.1 * size), b1, b2)
                stick = replace(stick, edges=np.where(new[1] - new[0] < 1e-3 * size, start, new))
            solved = np.max(np.abs(found), axis=0) < 1e-8 * self.contact.compliance * self.friction * stick.loads[0]
            solved &= (np.max(np.abs(change), axis=0) < 1e-9 * size) & (2 * stick.half < (1 - 1e-7) * size)
            for k in sorted(np.flatnonzero(solved).tolist(), key=lambda k: -stick.half[k]):
                one = stick.part(k, k + 1)
                reserve = one.shear_reserve(one.middle[:, None] + one.half[:, None] * np.linspace(-0.96, 0.96, 49))
                if np.min(reserve) > -_WRONG * np.max(reserve):
                    self.counts["jumps"] += 1
                    first, last = one.edges[:, 0].tolist()
                    return self._held(replace(state, edges=(first, last)), slips, float(time))
        return None

    def run(self, state: State, end: float) -> tuple[list[Step], State]:
        """Steps up to a time, and the state there.

        Raises
        ------
        NotOneStickInterval
            Where stick breaks into several intervals, and where a step does not converge however short it is.
        """
        steps: list[Step] = []
        turned, trial = set[int](), self.longest
        while state.time < end - _SOON * self.longest:
            state, slips = self._next_slips(state, turned)
            ahead = self.loads.corners[self.loads.corners > state.time + _SOON * self.longest]
            stop = min(end, float(ahead[0])) if len(ahead) else end
            searched = False
            while True:
                until = stop if stop - state.time < 1.2 * trial else state.time + trial
                with np.errstate(all="ignore"):
                    found = self._to_event(state, slips, until)
                # The last coefficients of the edges.
                if found is not None and np.max(np.abs(_fit(found[0].stick.edges.T)[-2:])) < _RESOLVED * found[0].stick.width / 2:
                    (step, event), turned = found, set()
                    step, state = self._finished(step)
                    if event is not None and event[1] == "turn":
                        turned = {event[2]}
                    if event is not None and event[1] == "gone":
                        state = state.closed(event[2], float(step.stick.contact_edges[(event[2] + 1) // 2, -1]))
                    trial = min(self.longest, 2 * trial)
                    break
                trial, held = min(trial, until - state.time) / 2, None
                with np.errstate(all="ignore"):
                    turn = self._turn(state, slips, stop)
                    now = self._stick(state, slips, np.array([state.time, turn]))
                    left = float(np.max(np.ptp(now.excess(), axis=1)))
                    if 0 not in slips and left < _CLOSING * self.contact.compliance * self.friction * now.loads[0, 0]:
                        self.counts["bridged"] += 1
                        held = self._held(state, slips, turn)
                    elif 0 not in slips and trial <= 2 * _SHORTEST * self.longest and not searched:
                        held, searched = self._jump(state, slips, stop), True
                if held is not None:
                    (step, state), trial, turned = held, self.longest / 16, set()
                    break
                if trial <= _SHORTEST * self.longest:
                    raise NotOneStickInterval(
                        f"load: the edges of stick could not be followed past time {state.time:.6g}, where the engine has no state "
                        "for them; with bulk stress and tilt in phase with the loads it has more often, finite elements take any"
                    )
            if step.wrong > _WRONG:
                raise _broken(float(step.time[-1]), step.where, "friction would be broken inside what slips or sticks")
            steps.append(step)
        return steps, state


def _broken(time: float, where: float, why: str) -> NotOneStickInterval:
    return NotOneStickInterval(
        f"load: the stick zone breaks into several intervals near time {time:.6g} at x = {where:.6g} ({why}); half-plane theory "
        "here follows one interval: bulk stress and tilt in phase with the loads keep one more often, finite elements take any"
    )


# ---------------------------------------------------------------------------------------------------- paths and answers
@dataclass(frozen=True, eq=False)
class PathLoads:
    """P, Q, eps and alpha of a load path; of several times at once only within one leg, which is that of their mean.

    `strain` is what the bulk stress of the lower and of the upper body adds to eps, `radius` that of the parabola, for a moment.
    """

    path: LoadPath
    strain: tuple[float, float]
    radius: float

    def _place(self, time: float) -> tuple[LoadSegment, float]:
        """The leg at a time, and by how much it is late."""
        late = 0.0
        if self.path.period is not None and time > self.path.cycle_start:
            late = math.floor((time - self.path.cycle_start) / self.path.period) * self.path.period
        legs = (*self.path.initial_loading, *self.path.cycle)
        return next((leg for leg in legs if time - late <= leg.end), legs[-1]), late

    def _parts(self, time: Array, name: Literal["loads", "rates"]) -> tuple[Array, ...]:
        """P, Q, eps, tilt and moment at times within one leg, or their rates: (n,) each."""
        leg, late = self._place(float(np.mean(time)))
        nothing = (0.0 * time, 0.0 * time)
        pairs = [getattr(part, name)(time - late) if part is not None else nothing for part in (leg, leg.bulk, leg.turning)]
        (p, q), (lower, upper), (tilt, moment) = pairs
        return tuple(np.broadcast_arrays(p, q, self.strain[0] * lower + self.strain[1] * upper, tilt, moment))

    def values(self, time: Array) -> Array:
        """(4, n)."""
        p, q, eps, tilt, moment = self._parts(time, "loads")
        if self.path.moment_given:
            tilt = -moment / (self.radius * np.where(p > 0, p, np.inf))
        return np.stack([p, q, eps, tilt])

    def rates(self, time: Array) -> Array:
        """(4, n)."""
        p, q, eps, tilt, moment = self._parts(time, "rates")
        if self.path.moment_given:
            load, _, _, _, given = self._parts(time, "loads")
            tilt = -(moment * load - given * p) / (self.radius * load**2)
        return np.stack([p, q, eps, tilt])

    def stresses(self, time: Array) -> Array:
        """Bulk stress of the lower and of the upper body, (2, n), for any times."""
        found = np.zeros((2, len(time)))
        for k, each in enumerate(time):
            leg, late = self._place(float(each))
            if leg.bulk is not None:
                found[:, k] = leg.bulk.loads(float(each) - late)
        return found

    def corners(self, cycles: int) -> Array:
        """Times at which a leg ends or a load turns round: an edge that turns there has no solution on the way it went."""
        late = np.arange(cycles)[:, None] * (self.path.period or 0.0)
        first, cycle = ([time for leg in legs for time in self.turns(leg)] for legs in (self.path.initial_loading, self.path.cycle))
        return np.unique(np.concatenate([first, (late + np.array(cycle)).ravel()]))

    def turns(self, leg: LoadSegment) -> list[float]:
        """The end of a leg and the turning points of P, Q, eps, tilt and moment in it; one time for all that turn together."""
        force, pairs = Combination(0.0, 1.0), [(leg, NORMAL_LOAD), (leg, Combination(0.0, 1.0))]
        pairs += [(leg.bulk, Combination(*self.strain))] if leg.bulk is not None else []
        pairs += [(leg.turning, NORMAL_LOAD), (leg.turning, force)] if leg.turning is not None else []
        found = [leg.end]
        for time in (time for part, what in pairs for time in part.turning_points(what)):
            if min(abs(time - known) for known in found) > 1e-6 * (leg.end - leg.start):
                found.append(time)
        return found


@dataclass(frozen=True, eq=False)
class Followed:
    """What was followed, n instants and k points; edges (n, 2), fields (n, k).

    Attributes
    ----------
    loads : (4, n) P, Q, eps and alpha
    moment, shear_moment : (n,) int x p and m_q = int x q
    displacement : (n,) U of x = 0, with the datum length 1 in the logarithm
    contact_edges, stick_edges : (n, 2)
    pressure, shear, slip, state : (n, k), as in a ContactSolution
    works : friction work of each cycle that was followed; of the whole path where none repeats
    loop : closed integral of Q dU - m_q d eps of the last
    remainder : estimate of what the work of the last cycle still is from the steady one
    steady_from, steady_to : index of the first cycle that repeats the one before to this share of W, None if none does
    density : (k,) friction work at the points, of the last cycle
    permanent_stick_edges : (2,) of the last cycle; NaN where none
    counts : see `Follower`
    errors : relative, of dissipation, dissipation_density, shear and slip, as in a Record
    """

    time: Array
    loads: Array
    moment: Array
    shear_moment: Array
    displacement: Array
    contact_edges: Array
    stick_edges: Array
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    works: Array
    loop: float
    remainder: float
    steady_from: int | None
    steady_to: float
    density: Array
    permanent_stick_edges: Array
    counts: dict[str, int]
    errors: dict[str, float]


def cycles_needed(path: LoadPath, time: Array | None) -> int:
    """How many cycles reach the last of some instants, one at least."""
    if path.period is None or time is None or not len(time):
        return 1
    return max(1, math.ceil((float(np.max(time)) - path.cycle_start) / path.period - 1e-9))


def first_repeat(works: Sequence[float] | Array, share: float) -> int | None:
    """Index of the first cycle whose work is that of the one before, to a share of it."""
    return next((k for k in range(1, len(works)) if abs(works[k] - works[k - 1]) <= share * works[k]), None)


def remainder_of(works: Sequence[float]) -> float:
    """How far the work of the last cycle may be from that of the steady one, from the trend of the changes.

    Geometric where the last two ratios of changes are below a half, alike and not rising. Else they may fall as slowly as k^-4,
    however fast the first ones were: k/3 times the last.

    >>> round(remainder_of([1.5, 1.05, 1.005, 1.0005]), 12)  # W falls to 1
    0.0005
    >>> works = [1 + k**-3.0 for k in range(1, 41)]  # 1.6e-5 is left
    >>> 1e-5 < remainder_of(works) < 3e-5
    True
    """
    changes = np.abs(np.diff(works))
    if len(changes) < 2 or changes[-1] == 0:
        return float(changes[-1]) if len(changes) else math.inf
    before, ratio = np.append(1.0, changes[1:] / np.maximum(changes[:-1], np.finfo(float).tiny))[-2:].tolist()
    if ratio < 0.5 and 0.8 * before < ratio < 1.05 * before:
        return float(changes[-1]) * ratio / (1 - ratio)
    return float(changes[-1]) * max(len(works) / 3, min(ratio, 0.9) / (1 - min(ratio, 0.9)))


def _agreeing(work: float, loop: float, scale: float) -> float:
    """The closed integral of Q dU - m_q d eps of a cycle, where it is the friction work to 1e-6 or both are rounding of `scale`.

    >>> _agreeing(1.0, 1.0000001, 1.0)
    1.0000001
    >>> _agreeing(1.0, 1.00001, 1.0)
    Traceback (most recent call last):
    semi_analytic.fronts.NotOneStickInterval: load: friction work and closed integral of Q dU - m_q d eps differ by 1.0e-05 ...
    """
    if abs(loop - work) > 1e-6 * work + 1e-11 * scale:
        raise NotOneStickInterval(
            f"load: friction work and closed integral of Q dU - m_q d eps differ by {abs(loop / work - 1):.1e} of the work of the "
            "last cycle: it is not steady, or its fronts were not followed well enough; more cycles or finite elements may help"
        )
    return loop


def follow(
    path: LoadPath,
    contact: Parabola,
    friction: float,
    strain: tuple[float, float],
    x: Array,
    time: Array | None = None,
    *,
    most: int = 12,
    order: int = ORDER,
) -> Followed:
    """Follow a load path with bulk stress and tilt from first touch, cycle by cycle until it is steady.

    Parameters
    ----------
    path : P, Q, bulk stresses, and tilt or moment; the first leg of its initial loading starts from nothing
    contact : the parabola, with A = 2/E*
    friction : f
    strain : what the bulk stress of the lower and of the upper body adds to eps, 1/E' and -1/E' with E' = E/(1 - nu^2)
    x : (k,) points
    time : (n,) instants in any order; those of the steps if None
    most : largest number of cycles; they are followed until one repeats the one before to 1e-8 of its work
    order : degree in time of a step

    Raises
    ------
    NotOneStickInterval
        (an InputError) where stick breaks into several intervals, as with bulk stress or tilt out of phase with P and Q, and where
        the work of the last cycle is not its closed integral.
    InadmissibleLoadError
        For gross sliding and separation.
    """
    check([*path.initial_loading, *path.cycle], friction)
    loads = PathLoads(path, strain, contact.radius)
    first, period = path.initial_loading[0], path.period
    needed = cycles_needed(path, time)
    most = max(most, needed)
    longest = (period if period is not None else path.cycle_start - path.start) / 16
    follower = Follower(contact, friction, Loads(loads.values, loads.rates, loads.corners(most)), longest, order)
    straight = all(part is None or part.is_straight for part in (first, first.bulk, first.turning))
    # Of a curved leg but the begin: what bulk and tilt change by then is below 1e-6 of the end.
    touch, state = follower.touch(first.start, first.end if straight else first.start + 1e-4 * (first.end - first.start))
    steps, state = follower.run(state, path.cycle_start)
    steps = [touch, *steps]
    last, works = steps, [math.fsum(step.work for step in steps)] if period is None else []
    while period is not None and len(works) < most:
        last, state = follower.run(state, path.cycle_start + (len(works) + 1) * period)
        steps = [*steps, *last]
        works.append(math.fsum(step.work for step in last))
        if len(works) >= max(needed, 2) and abs(works[-1] - works[-2]) <= STEADY * works[-1]:
            break
    loop = math.fsum(_loop_of(step) for step in last)
    if period is not None:
        loop = _agreeing(works[-1], loop, contact.compliance * (friction * float(np.max(last[0].stick.loads[0]))) ** 2)
    steady = first_repeat(works, STEADY)
    # Where a loop closes, or a path just ends, all errors may be twice what the balance of energy leaves.
    stored = last[-1].stick.shear_energy(2 * order) if period is None else 0.0
    checked = works[-1] > 0 and (steady is not None or period is None)
    error = ERROR + (2 * abs((loop - stored) / works[-1] - 1) if checked else 0.0)
    instants = np.unique(np.concatenate([step.time[::2] for step in steps])) if time is None else np.asarray(time, dtype=float)
    low = max(float(np.max(step.stick.edges[0])) for step in last)
    high = min(float(np.min(step.stick.edges[1])) for step in last)
    return Followed(
        time=instants,
        **_at(follower, steps, instants, x),
        works=np.array(works),
        loop=loop,
        remainder=remainder_of(works),
        steady_from=steady,
        steady_to=STEADY,
        density=np.sum([_density_of(step, x, loads) for step in last], axis=0),
        permanent_stick_edges=np.array([low, high] if low < high else [math.nan, math.nan]),
        counts=dict(follower.counts),
        errors=dict.fromkeys(("dissipation", "dissipation_density", "shear", "slip"), error),
    )


def _loop_of(step: Step) -> float:
    """Integral of Q dU - m_q d eps over a step."""
    (U, moment), (_, Q, eps, _) = step.stick.displacement(), step.stick.loads
    dU, deps = (_value(_nodes(len(U) - 1), np.asarray(chebyshev.chebder(_fit(each)), dtype=float)) for each in (U, eps))
    return _integral(Q * dU - moment * deps)


def _at(follower: Follower, steps: Sequence[Step], time: Array, x: Array) -> dict[str, Any]:
    """What `Followed` has at instants (n,), by its names."""
    n, m = len(time), len(x)
    found: dict[str, Any] = {name: np.zeros((n, m)) for name in ("pressure", "shear", "slip", "state")}
    found |= {name: np.zeros((n, 2)) for name in ("contact_edges", "stick_edges")}
    found |= {name: np.zeros(n) for name in ("displacement", "shear_moment")} | {"loads": np.zeros((4, n))}
    ends = np.array([each.time[-1] for each in steps])
    number = np.minimum(np.searchsorted(ends, time - _SOON * follower.longest), len(steps) - 1)
    before = time < steps[0].time[0]  # out of contact, but for the last 1e-4 of the load that touches first
    for k in np.flatnonzero(before):
        found["loads"][:, k] = np.nan_to_num(follower.loads.values(time[k : k + 1])[:, 0])
        found["slip"][k] = -found["loads"][2, k] * x
    found["state"][before] = OPEN
    for k in np.unique(number[~before]):
        whole = np.flatnonzero((number == k) & ~before)
        for some in np.array_split(whole, -(-len(whole) // _TOGETHER)):
            stick = steps[k].at(time[some], follower.loads)
            found["loads"][:, some] = stick.loads
            found["contact_edges"][some], found["stick_edges"][some] = stick.contact_edges.T, stick.edges.T
            found["displacement"][some], found["shear_moment"][some] = stick.displacement()
            for name, values in zip(("pressure", "shear", "slip", "state"), stick.fields(x, 2 * follower.order), strict=True):
                found[name][some] = values
    found["moment"] = found["loads"][0] * np.mean(found["contact_edges"], axis=1)
    return found | {"state": found["state"].astype(np.int8)}


def _density_of(step: Step, x: Array, loads: PathLoads) -> Array:
    """Friction work at points (k,) over a step: f p |ds/dt| over the time that each is in a slip zone."""
    found, fine, stick = np.zeros(len(x)), np.linspace(-1, 1, 65), step.stick
    series, duration = [_fit(edges) for edges in (*stick.edges, *stick.contact_edges)], step.time[-1] - step.time[0]
    for i, side in _SIDES:

        def depth(phi: Array, at: Array, i: int = i, side: int = side) -> Array:
            """Distance from the nearer end of the slip zone, positive within it."""
            return np.minimum(side * (at - _value(phi, series[i])), side * (_value(phi, series[i + 2]) - at))

        inside = depth(fine[:, None], x) if stick.slips[i] else np.zeros((len(fine), len(x)))
        for k in np.flatnonzero(np.max(inside, axis=0) > 0):
            turns = np.flatnonzero((inside[1:, k] > 0) != (inside[:-1, k] > 0))
            marks = [
                -1.0,
                *(float(scipy.optimize.brentq(depth, fine[j], fine[j + 1], args=(x[k],), xtol=1e-14)) for j in turns),
                1.0,
            ]
            for begin, end in pairwise(marks):
                phi = begin + (end - begin) * np.sin(_ANGLE / 2) ** 2
                if np.min(depth(phi, x[k])) <= 0:
                    continue
                weight = (end - begin) / 2 * np.sin(_ANGLE) * _ANGLE_WEIGHT * np.cos(np.pi * phi / 2) * np.pi / 4 * duration
                there = step.at(step.time[0] + duration * np.sin(np.pi * (phi + 1) / 4) ** 2, loads)
                point = np.full((len(phi), 1), x[k])
                found[k] += stick.friction * np.sum(weight * (there.pressure(point) * there.slip_rate(side, point))[:, 0])
    return found
