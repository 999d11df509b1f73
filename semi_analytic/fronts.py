"""Front following: slip and stick of a parabola under any course of P, Q, bulk strain and tilt, while one stick interval remains.

# notation: A = 2/E*; p, q tractions, q > 0 on the lower face; s slip of the upper face over the lower; eps bulk strain,
#           alpha tilt; a1, a2 edges of contact, b1, b2 of stick; m, c middle and half-length of stick, zeta = x - m,
#           w = sqrt(c^2 - zeta^2); d = +1, -1 direction of slip; q = d (f p - q*), so that q* = 0 where they slip in direction d;
#           H principal value of int (.)/(x - xi) d xi

    h' + alpha = (A/pi) H p  in contact,    s' = (A/pi) H q - eps  everywhere         (like bodies, Dundurs' beta = 0)

The frozen slope s'(x) of the stick interval is the whole memory of friction. On stick (A/pi) H q* = F, with
F = f (h' + alpha) - d (s' + eps), and q* is bounded at both edges, of the total f P - d Q:

    int F/w = A K_0,    int zeta F/w = A (f P - d Q - K_1),    K_j = 2 f int_opposite p |zeta|^j / sqrt(zeta^2 - c^2) d xi

K_j is there where the zone at the other end slips in the opposite direction: q* = 2 f p in it. A *receding* stick edge follows
from these two equations at once, however long the step. A contact edge that *advances in stick* freezes the s' that it meets:
there s' is the unknown, a Volterra equation of the first kind in time. A zone that comes to rest freezes its s' as it is, by the
formula of H q* outside the stick interval. Steps end at events, and are spectral in time between them.

Where loads turn round with bulk or tilt out of phase, slip stops at the edge of contact first, and stick has several intervals. So
it may where a front meets what a loop has left. Both are found, by the sign of the slip rate and by |q| <= f p, and refused. There
remain loads that go on in one direction, and many cycles in phase. A cycle is given only where its friction work and its closed
integral of Q dU - m_q d eps agree to 1e-6.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.optimize import brentq

from scenes import NORMAL_LOAD, OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, Combination, InputError, LoadPath, LoadSegment
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
# What a step may leave unresolved, as share of the half-width; shortest step and longest stretch bridged, as shares of the longest.
_RESOLVED, _SHORTEST, _BRIDGED = 2e-9, 1e-7, 2e-3
# Share of A f P that the equations of the edges may change by while edges are held: 1e-7 moves them by 1e-8 of their size.
_CLOSING = 1e-7
# Instants of a step that are sampled together.
_TOGETHER = 16
# Share of the longest step that is no time: directions are those just after, and a corner that close has been reached.
_SOON = 1e-6
# Share of the largest slip rate, and of f p0, that may have the wrong sign: rounding of edges leaves 1e-9.
_WRONG = 1e-6
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(32)
_ANGLE, _ANGLE_WEIGHT = np.pi * (1 + _NODES) / 2, np.pi / 2 * _WEIGHTS


def _graded(count: int = 10) -> tuple[Array, Array]:
    x, w = np.polynomial.legendre.leggauss(count)
    at = np.concatenate([a + (b - a) * (1 + x) / 2 for a, b in pairwise(_PANELS)])
    return at, np.concatenate([(b - a) * w / 2 for a, b in pairwise(_PANELS)])


_V, _VW = _graded()
# Shares of an interval counted from one end, up to its middle: as they are, and for an inverse root at that end.
_PLAIN, _ROOT = (_V / 2, _VW / 2), (_V**2 / 2, _VW * _V)


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


_FITS: dict[int, Array] = {}


def _fit(values: Array) -> Array:
    """Chebyshev coefficients of values at `_nodes`, (n + 1, ...)."""
    n = len(values) - 1
    if n not in _FITS:
        _FITS[n] = np.asarray(np.linalg.inv(chebyshev.chebvander(_nodes(n), n)), dtype=float)
    return np.asarray(_FITS[n] @ values)


def _value(at: Array | float, coefficients: Array) -> Array:
    return np.asarray(chebyshev.chebval(at, coefficients))


def _slope(coefficients: Array) -> Array:
    return np.asarray(chebyshev.chebder(coefficients))


def _primitive(coefficients: Array) -> Array:
    """The integral from -1."""
    return np.asarray(chebyshev.chebint(coefficients, lbnd=-1.0), dtype=float)


def _integral(values: Array) -> float:
    """Integral over [-1, 1] of what has these values at `_nodes`."""
    even = _fit(values)[::2]
    return float(np.sum(even * 2 / (1 - (2.0 * np.arange(len(even))) ** 2)))


def _clenshaw(coefficients: Array, number: NDArray[np.intp], t: Array) -> Array:
    """Values of the series `number` (k,) out of (n + 1, pieces) at t, (k,) or (k, m)."""
    rows = coefficients[:, number, None] if t.ndim == 2 else coefficients[:, number]
    last, before, twice = np.zeros_like(t), np.zeros_like(t), 2 * t
    for row in rows[:0:-1]:
        last, before = twice * last - before + row, last
    return np.asarray(rows[0] + t * last - before)


def _inverse(coefficients: Array, wanted: Array) -> Array:
    """Where a rising series has these values, on [-1, 1]: Newton's method between bounds."""
    low, high, at = -np.ones(len(wanted)), np.ones(len(wanted)), np.zeros(len(wanted))
    slope = _slope(coefficients)
    for _ in range(100):
        miss = _value(at, coefficients) - wanted
        low, high = np.where(miss <= 0, at, low), np.where(miss >= 0, at, high)
        steep = _value(at, slope)
        new = at - miss / np.where(steep > 0, steep, 1.0)
        new = np.where((new >= low) & (new <= high) & (steep > 0), new, (low + high) / 2)
        if np.max(np.abs(new - at)) < 1e-13:
            return new
        at = new
    return at


def _first_root(values: Array, k: int) -> float:
    """The root of what has these values at `_nodes` and changes sign between node k - 1 and node k."""
    series, nodes = _fit(values), _nodes(len(values) - 1)
    low, high = float(nodes[k - 1]), float(nodes[k])
    for _ in range(55):
        middle = (low + high) / 2
        low, high = (middle, high) if _value(middle, series) > 0 else (low, middle)
    return (low + high) / 2


# ---------------------------------------------------------------------------------------------------- the frozen slope
class Piece:
    """s' on [low, high]: a Chebyshev series in theta of x = low + (high - low) sin(theta/2)^2, which resolves roots at both ends.

    `begin` is s at the low end; two neighbours have one s where they meet.
    """

    def __init__(self, low: float, high: float, coefficients: Array, begin: float = 0.0) -> None:
        self.low, self.high, self.slope, self.begin = low, high, coefficients, begin
        at = _nodes(2 * len(coefficients) + 8)
        rate = _value(at, coefficients) * (high - low) * np.sin(np.pi * (at + 1) / 2) * np.pi / 4
        self.rise = _primitive(_fit(rate))

    @staticmethod
    def places(low: float, high: float, n: int) -> Array:
        """The points x of the n + 1 nodes."""
        return np.asarray(low + (high - low) * np.sin(np.pi * (_nodes(n) + 1) / 4) ** 2)

    def _at(self, x: Array | float) -> Array:
        share = np.clip((np.asarray(x) - self.low) / (self.high - self.low), 0, 1)
        return np.asarray(4 / np.pi * np.arcsin(np.sqrt(share)) - 1)

    def slope_at(self, x: Array | float) -> Array:
        """s'(x)."""
        return _value(self._at(x), self.slope)

    def slip_at(self, x: Array | float) -> Array:
        """s(x)."""
        return self.begin + _value(self._at(x), self.rise)

    def part(self, low: float, high: float) -> Piece:
        """The piece between two of its points."""
        low, high = max(low, self.low), min(high, self.high)
        if (low, high) == (self.low, self.high):
            return self
        series = _fit(self.slope_at(self.places(low, high, max(len(self.slope) - 1, 1))))
        return Piece(low, high, series, float(self.slip_at(low)))


def _merged(pieces: Sequence[Piece], scale: float) -> list[Piece]:
    """Neighbours put together where one series resolves both to `scale`."""
    done = [pieces[0]]
    for piece in pieces[1:]:
        last = done[-1]
        n = 2 * ORDER
        x = Piece.places(last.low, piece.high, n)
        both = _fit(np.where(x < piece.low, last.slope_at(x), piece.slope_at(x)))
        one = Piece(last.low, piece.high, both, last.begin)
        test = np.concatenate([np.linspace(each.low, each.high, 13) for each in (last, piece)])
        true = np.where(test < piece.low, last.slope_at(test), piece.slope_at(test))
        if max(np.max(np.abs(one.slope_at(test) - true)), np.max(np.abs(both[-3:]))) < scale:
            done[-1] = one
        else:
            done.append(piece)
    return done


class Quadrature(NamedTuple):
    """Nodes on parts of stick intervals: rows (k,) of the intervals, then (k, m) each: x, weight, s', s, x - b1, b2 - x."""

    row: NDArray[np.intp]
    x: Array
    weight: Array
    slope: Array
    slip: Array
    up: Array
    down: Array


class Frozen:
    """Pieces of the frozen s' side by side, from left to right."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces = list(pieces)
        self.low, self.high = (np.array([getattr(p, name) for p in pieces]) for name in ("low", "high"))
        self.begin, self.length = np.array([p.begin for p in pieces]), self.high - self.low
        self._slope, self._rise = (self._stacked([getattr(p, name) for p in pieces]) for name in ("slope", "rise"))
        share, weight = _PLAIN
        every = np.arange(len(pieces))
        length, near = self.length[:, None], np.sin(np.pi * share / 2) ** 2
        self._up, self._down = (length * np.concatenate(two) for two in ((near, 1 - near), (1 - near, near)))
        bent = np.sin(np.pi * share) * np.pi * weight / 2
        self._weight = length * np.concatenate([bent, bent])
        at = np.broadcast_to(2 * np.concatenate([share, 1 - share]) - 1, (len(pieces), 2 * len(share)))
        self._slopes, self._slips = _clenshaw(self._slope, every, at), _clenshaw(self._rise, every, at) + self.begin[:, None]

    @staticmethod
    def _stacked(rows: Sequence[Array]) -> Array:
        found = np.zeros((max(len(row) for row in rows), len(rows)))
        for number, row in enumerate(rows):
            found[: len(row), number] = row
        return found

    def _theta(self, number: NDArray[np.intp], x: Array) -> Array:
        return np.asarray(2 * np.arcsin(np.sqrt(np.clip((x - self.low[number]) / self.length[number], 0, 1))))

    def _number(self, x: Array) -> NDArray[np.intp]:
        return np.asarray(np.clip(np.searchsorted(self.high, x), 0, len(self.high) - 1))

    def slope(self, x: Array) -> Array:
        """s'(x), (n,)."""
        number = self._number(x)
        return _clenshaw(self._slope, number, 2 * self._theta(number, x) / np.pi - 1)

    def slip(self, x: Array) -> Array:
        """s(x), (n,)."""
        number = self._number(x)
        return _clenshaw(self._rise, number, 2 * self._theta(number, x) / np.pi - 1) + self.begin[number]

    def quadratures(self, b1: Array, b2: Array, *, slip: bool = False) -> list[Quadrature]:
        """Nodes of [b1, b2] (n,), piece by piece, with distances from both edges that do not cancel; s where asked for."""
        left, right = b1[:, None], b2[:, None]
        inside = np.minimum(right, self.high) > np.maximum(left, self.low)
        whole = inside & (left <= self.low) & (right >= self.high)
        found = []
        k, p = np.nonzero(whole)
        if len(k):
            up, down = self._up[p] + (self.low[p] - b1[k])[:, None], self._down[p] + (b2[k] - self.high[p])[:, None]
            x = self.low[p][:, None] + self._up[p]
            found.append(Quadrature(k, x, self._weight[p], self._slopes[p], self._slips[p], up, down))
        k, p = np.nonzero(inside & ~whole)
        if len(k):
            cut1, cut2 = (b1[k] > self.low[p])[:, None], (b2[k] < self.high[p])[:, None]
            begin = np.where(cut1, self._theta(p, b1[k])[:, None], 0.0)
            end = np.where(cut2, self._theta(p, b2[k])[:, None], np.pi)
            span, length = end - begin, self.length[p][:, None]
            first, last = np.where(cut1, _ROOT[0], _PLAIN[0]), np.where(cut2, _ROOT[0], _PLAIN[0])
            weight = span * np.concatenate([np.where(cut1, _ROOT[1], _PLAIN[1]), np.where(cut2, _ROOT[1], _PLAIN[1])], axis=1)
            after, ahead = (span * np.concatenate(two, axis=1) for two in ((first, 1 - last), (1 - first, last)))
            theta = np.concatenate([begin + span * first, end - span * last], axis=1)
            up = length * np.sin((theta + begin) / 2) * np.sin(after / 2)
            down = length * np.sin((theta + end) / 2) * np.sin(ahead / 2)
            x = np.where(cut1, b1[k][:, None], self.low[p][:, None]) + up
            up = np.where(cut1, up, up + (self.low[p] - b1[k])[:, None])
            down = np.where(cut2, down, down + (b2[k] - self.high[p])[:, None])
            at, weight = 2 * theta / np.pi - 1, weight * length / 2 * np.sin(theta)
            slips = _clenshaw(self._rise, p, at) + self.begin[p][:, None] if slip else theta
            found.append(Quadrature(k, x, weight, _clenshaw(self._slope, p, at), slips, up, down))
        return found

    def moments(self, b1: Array, b2: Array, *, slip: bool = False) -> Array:
        """int s'/w, int zeta s'/w and, where asked for, int zeta^2 s'/w and int s/w over [b1, b2] (n,): (2 or 4, n)."""
        found = np.zeros((4 if slip else 2, len(b1)))
        for each in self.quadratures(b1, b2, slip=slip):
            w, zeta = each.weight / np.sqrt(each.up * each.down), (each.up - each.down) / 2
            wanted = (each.slope, zeta * each.slope, zeta**2 * each.slope, each.slip)
            for row, values in enumerate(wanted[: len(found)]):
                found[row] += np.bincount(each.row, np.sum(w * values, axis=1), len(b1))
        return found


# ---------------------------------------------------------------------------------------------------------- the contact
@dataclass(frozen=True)
class Parabola:
    """Frictionless contact of h = x^2/(2 R) under P and tilt: middle -alpha R, half-length sqrt(2 A R P/pi) (Hertz)."""

    compliance: float
    radius: float

    def edges(self, load: Array, tilt: Array) -> tuple[Array, Array]:
        """a1 and a2, (n,) each."""
        middle, half = -tilt * self.radius, np.sqrt(2 * self.compliance * self.radius * load / np.pi)
        return middle - half, middle + half

    def pressure(self, x: Array, a1: Array, a2: Array) -> Array:
        """p(x), 0 outside."""
        return np.asarray(np.sqrt(np.maximum((x - a1) * (a2 - x), 0.0)) / (self.compliance * self.radius))

    def slope(self, x: Array) -> Array:
        """h'(x)."""
        return x / self.radius

    def moments(self, b1: Array, b2: Array) -> tuple[Array, Array]:
        """int h'/w and int zeta h'/w over [b1, b2]."""
        m, c = (b1 + b2) / 2, (b2 - b1) / 2
        return np.pi * m / self.radius, np.pi * c**2 / 2 / self.radius

    def beyond(self, x: Array, a1: Array, a2: Array) -> Array:
        """(A/pi) H p = h' + alpha inside [a1, a2], and outside."""
        zeta, half = x - (a1 + a2) / 2, (a2 - a1) / 2
        return np.asarray((zeta - np.sign(zeta) * np.sqrt(np.maximum(zeta**2 - half**2, 0.0))) / self.radius)


_GROWING: dict[int, tuple[Array, Array, Array, Array]] = {}


def _growing_rule(n: int) -> tuple[Array, Array, Array, Array]:
    """Quadrature on what has been frozen since a step began, for its nodes k = 1..n.

    Weights (n, m) on [-1, phi_k]; cardinal functions, derivatives T_j' and differences T_j(phi_k) - T_j(phi), (n, m, n + 1) each.
    """
    if n not in _GROWING:
        last = _nodes(n)[1:]
        length = (last + 1)[:, None]
        # At the end of a step edges move as the square of 1 - phi: roots in x are none in phi there.
        end = (last == last[-1])[:, None]
        share, weight = np.where(end, _PLAIN[0], _ROOT[0]), np.where(end, _PLAIN[1], _ROOT[1])
        begin = np.broadcast_to(_PLAIN[0], share.shape)
        phi = np.concatenate([-1 + length * begin, last[:, None] - length * share], axis=1)
        gap = length * np.concatenate([1 - begin, share], axis=1)
        at, there = chebyshev.chebvander(phi, n), chebyshev.chebvander(last, n)
        quotient = np.zeros((*phi.shape, n + 1))
        quotient[..., 1] = 1
        for j in range(1, n):
            quotient[..., j + 1] = 2 * (there[:, None, j] + phi * quotient[..., j]) - quotient[..., j - 1]
        derivative = np.zeros((n + 1, n + 1))
        for j in range(1, n + 1):
            series = _slope(np.eye(n + 1)[j])
            derivative[: len(series), j] = series
        weights = length * np.concatenate([np.broadcast_to(_PLAIN[1], share.shape), weight], axis=1)
        _fit(np.zeros(n + 1))
        _GROWING[n] = weights, at @ _FITS[n], at @ derivative, quotient * gap[..., None]
    return _GROWING[n]


def _growing_moments(side: int, b1: Array, b2: Array) -> tuple[Array, Array]:
    """What s' at node j of a growing piece adds to int s'/w and int zeta s'/w at node k = 1..n: (n, n + 1) each."""
    weight, cardinal, derivative, difference = _growing_rule(len(b1) - 1)
    edge, far = (b2, b1) if side > 0 else (-b1, -b2)
    series, whole = _fit(edge), (edge - far)[1:, None]
    gap = difference @ series  # distance from the edge
    w = (derivative @ series) * weight / np.sqrt(gap * (whole - gap))
    zeta = side * (whole / 2 - gap)
    return np.einsum("ki,kij->kj", w, cardinal), np.einsum("ki,kij->kj", w * zeta, cardinal)


class State:
    """An instant: edges of stick, direction of slip at either end (0: stick up to the edge of contact), the frozen s'."""

    def __init__(self, time: float, stick: tuple[float, float], slips: tuple[int, int], pieces: Sequence[Piece]) -> None:
        self.time, self.b1, self.b2, self.slips = time, *stick, slips
        tiny = 1e-11 * (self.b2 - self.b1)
        inside = [p for p in pieces if p.high > self.b1 + tiny and p.low < self.b2 - tiny and p.high > p.low + tiny]
        self.frozen = Frozen(inside)

    @property
    def stick(self) -> tuple[float, float]:
        """Both edges of stick."""
        return self.b1, self.b2

    @property
    def edges(self) -> tuple[Array, Array]:
        """The same as arrays (1,)."""
        return np.array([self.b1]), np.array([self.b2])

    def edge(self, side: int) -> float:
        """The stick edge of a side."""
        return self.b2 if side > 0 else self.b1

    def end_piece(self, side: int) -> Piece:
        """The outermost piece of a side."""
        return self.frozen.pieces[-1 if side > 0 else 0]

    def end_slope(self, side: int) -> float:
        """s' at the stick edge of a side."""
        return float(self.end_piece(side).slope_at(self.edge(side)))

    def joined(self, side: int, low: float, high: float, coefficients: Array) -> list[Piece]:
        """The pieces with one more at a side, [low, high], that begins at the stick edge."""
        pieces, new = list(self.frozen.pieces), Piece(low, high, coefficients)
        if side > 0:
            head = pieces[-1].part(pieces[-1].low, low)
            new.begin = float(head.slip_at(low))
            return [*pieces[:-1], head, new]
        head = pieces[0].part(high, pieces[0].high)
        new.begin = float(head.slip_at(high) - _value(1.0, new.rise))
        return [new, head, *pieces[1:]]

    def without_slivers(self, side: int) -> State:
        """With the stick edge moved to an old edge within 1e-8 of the stick interval: a loop that closes brings it back there."""
        near, edge = 1e-8 * (self.b2 - self.b1), self.edge(side)
        ends = [p.low if side > 0 else p.high for p in self.frozen.pieces]
        close = [x for x in ends if 0 <= side * (edge - x) < near]
        if not close:
            return self
        stick = (self.b1, min(close)) if side > 0 else (max(close), self.b2)
        return State(self.time, stick, self.slips, self.frozen.pieces)


@dataclass
class Step:
    """A stretch of time without events. Values at nodes 0..n of phi, with time = begin + duration sin(pi (1 + phi)/4)^2.

    `slips` are the directions at both ends: +1, -1, or 0 for a contact edge that advances in stick. `frozen` holds all of s' that
    is frozen at the end. `work` is the friction work, `wrong` the largest share of slip rate or f p0 that breaks a law of friction,
    at x = `where`.
    """

    slips: tuple[int, int]
    time: Array
    loads: Array
    rates: Array
    a1: Array
    a2: Array
    b1: Array
    b2: Array
    frozen: Frozen
    grown: tuple[tuple[int, Array], ...] = ()
    work: float = 0.0
    wrong: float = 0.0
    where: float = 0.0

    @property
    def opposite(self) -> bool:
        """Whether both ends slip, in opposite directions."""
        return self.slips[0] * self.slips[1] < 0

    @property
    def edges(self) -> tuple[Array, Array, Array, Array]:
        """a1, a2, b1, b2."""
        return self.a1, self.a2, self.b1, self.b2

    @property
    def size(self) -> float:
        """Width of the contact at first."""
        return float(self.a2[0] - self.a1[0])

    def phi(self, time: Array) -> Array:
        """Place of times within the step, in [-1, 1]."""
        share = np.clip((time - self.time[0]) / (self.time[-1] - self.time[0]), 0, 1)
        return np.asarray(4 / np.pi * np.arcsin(np.sqrt(share)) - 1)


def _times(begin: float, end: float, n: int) -> Array:
    time = begin + (end - begin) * np.sin(np.pi * (_nodes(n) + 1) / 4) ** 2
    time[-1] = end
    return time


def _zone(low: Array, high: Array) -> tuple[Array, Array]:
    """Nodes and weights (n, m) of [low, high] (n,) for roots at both ends."""
    half = ((high - low) / 2)[:, None]
    return (low + high)[:, None] / 2 - half * np.cos(_ANGLE), half * np.sin(_ANGLE) * _ANGLE_WEIGHT


def _root_beyond(zeta: Array, c: Array) -> Array:
    """sqrt(zeta^2 - c^2) > 0, also where a zone has no width yet, with nothing in it."""
    return np.sqrt(np.maximum((zeta - c) * (zeta + c), (1e-10 * c) ** 2))


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
    counts : steps, tries, iterations of Newton's method, jumps of an edge, stretches bridged
    """

    contact: Parabola
    friction: float
    loads: Loads
    longest: float
    order: int = ORDER
    fastest: float = np.finfo(float).tiny
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(("steps", "tries", "iterations", "jumps", "bridged"), 0))

    # ------------------------------------------------------------------------------------------------ laws at an instant
    def _residual(
        self, frozen: Frozen, loads: Array, edges: tuple[Array, Array, Array, Array], slips: tuple[int, int]
    ) -> tuple[Array, Array]:
        """Of the two equations of the stick edges, (n,) each, without what a step adds to s'."""
        (P, Q, eps, alpha), (a1, a2, b1, b2), f, A = loads, edges, self.friction, self.contact.compliance
        d = slips[1] or slips[0] or 1
        m, c = (b1 + b2) / 2, (b2 - b1) / 2
        (g0, g1), (h0, h1) = frozen.moments(b1, b2), self.contact.moments(b1, b2)
        first = f * h0 - d * g0 + np.pi * (f * alpha - d * eps)
        second = f * h1 - d * g1 - A * (f * P - d * Q)
        if slips[0] * slips[1] < 0:
            x, weight = _zone(a1, b1)
            zeta = x - m[:, None]
            p = 2 * A * f * weight * self.contact.pressure(x, a1[:, None], a2[:, None]) / _root_beyond(-zeta, c[:, None])
            first, second = first - np.sum(p, axis=1), second - np.sum(p * zeta, axis=1)
        return first, second

    def _pressure_rate(self, x: Array, rates: Array, a1: Array, a2: Array) -> Array:
        """dp/dt at x (n, m)."""
        turning = rates[3][:, None] / self.contact.compliance * (x - ((a1 + a2) / 2)[:, None])
        return np.asarray(
            (rates[0][:, None] / np.pi - turning) / np.sqrt(np.maximum((x - a1[:, None]) * (a2[:, None] - x), np.finfo(float).tiny))
        )

    def _edge_load(self, side: int, d: int, opposite: bool, rates: Array, edges: tuple[Array, Array, Array, Array]) -> Array:
        """K of q*' = K/(pi w) at the stick edge of a side that slips in direction d, (n,): negative where the edge recedes."""
        (P, Q, eps, alpha), (a1, a2, b1, b2), f = rates, edges, self.friction
        load = f * P - d * Q - side * np.pi * (b2 - b1) / 2 / self.contact.compliance * (f * alpha - d * eps)
        if opposite:
            x, weight = _zone(a1, b1) if side > 0 else _zone(b2, a2)
            near, far = (b1, b2) if side > 0 else (b2, b1)
            share = np.sqrt((x - near[:, None]) / (x - far[:, None]))
            load = load - 2 * f * np.sum(weight * self._pressure_rate(x, rates, a1, a2) * share, axis=1)
        return np.asarray(load)

    def _at_contact_edge(
        self, side: int, other: int, rates: Array, edges: tuple[Array, Array, Array, Array]
    ) -> tuple[Array, Array]:
        """Strengths of q' and of f p' at a contact edge that sticks, (n,) each; `other` is the slip at the other end."""
        a1, a2, b1, b2 = edges
        c, d = (a2 - a1) / 2, other or 1
        pressure = self.friction * (rates[0] - side * np.pi * c / self.contact.compliance * rates[3]) / np.sqrt(2 * c)
        return d * (pressure - self._edge_load(side, d, False, rates, edges) / np.sqrt(b2 - b1)), pressure

    def slip_rate(
        self, side: int, slips: tuple[int, int], x: Array, rates: Array, edges: tuple[Array, Array, Array, Array]
    ) -> Array:
        """d ds/dt at x (n, m) in the slip zone of a side: positive."""
        (P, Q, eps, alpha), (a1, a2, b1, b2), f, A = rates, edges, self.friction, self.contact.compliance
        d = slips[1] if side > 0 else slips[0]
        m, c = ((b1 + b2) / 2)[:, None], ((b2 - b1) / 2)[:, None]
        zeta = side * (x - m)
        past = np.maximum(side * (x - (b2 if side > 0 else b1)[:, None]), 0.0)
        w = np.sqrt(past * (past + 2 * c))
        load, turning = (f * P - d * Q)[:, None], side * (f * alpha - d * eps)[:, None]
        rate = turning * w - A / np.pi * load * np.arctanh(w / zeta)
        if slips[0] * slips[1] < 0:
            xi, weight = _zone(a1, b1) if side > 0 else _zone(b2, a2)
            p = weight * self._pressure_rate(xi, rates, a1, a2)
            there = (side * (xi - m))[:, None, :]
            ratio = (c[:, :, None] ** 2 - there * zeta[:, :, None]) / (c[:, :, None] * (zeta[:, :, None] - there))
            rate = rate + 2 * A / np.pi * f * np.einsum("kj,kij->ki", p, np.arccosh(np.maximum(ratio, 1.0)))
        return np.asarray(rate)

    def _drive(self, x: Array, slope: Array, loads: Array, d: int) -> Array:
        """F = f (h' + alpha) - d (s' + eps) at x (n, m), where the frozen s' is `slope`; loads (4, n)."""
        return np.asarray(self.friction * (self.contact.slope(x) + loads[3, :, None]) - d * (slope + loads[2, :, None]))

    def _means(self, frozen: Frozen, x: Array, datum: Array, loads: Array, stick: tuple[Array, Array], d: int) -> Array:
        """int [F(y) - F_0]/[w(y) (y - x)] dy over the stick intervals (n,), at x and with F_0 = `datum` (n, m)."""
        total = np.zeros(x.shape)
        for each in frozen.quadratures(*stick):
            k = each.row
            inverse = each.x[:, None, :] - x[k][:, :, None]
            np.divide(1.0, inverse, out=inverse, where=inverse != 0)
            rise = self._drive(each.x, each.slope, loads[:, k], d)[:, None, :] - datum[k][:, :, None]
            rise *= inverse
            np.add.at(total, k, np.einsum("kn,kmn->km", each.weight / np.sqrt(each.up * each.down), rise))
        return total

    def _far_zone(self, side: int, x: Array, edges: tuple[Array, Array, Array, Array]) -> Array:
        """int p/[sqrt((xi - b1) (xi - b2)) (x - xi)] d xi over the slip zone of a side, at x (n, m)."""
        a1, a2, b1, b2 = edges
        xi, weight = _zone(a1, b1) if side < 0 else _zone(b2, a2)
        # A zone has no width yet where it begins: nothing is in it.
        least = np.square(1e-10 * (b2 - b1))[:, None]
        root = np.sqrt(np.maximum((xi - b1[:, None]) * (xi - b2[:, None]), least))
        p = weight * self.contact.pressure(xi, a1[:, None], a2[:, None]) / root
        return np.sum(p[:, None, :] / (x[:, :, None] - xi[:, None, :]), axis=2)

    def shear_reserve(
        self, frozen: Frozen, x: Array, loads: Array, edges: tuple[Array, Array, Array, Array], slips: tuple[int, int]
    ) -> Array:
        """q*/w at x (n, m) within the stick interval at instants (n,): q = d (f p - q*)."""
        d = slips[1] or slips[0] or 1
        here = self._drive(x, frozen.slope(x.ravel()).reshape(x.shape), loads, d)
        total = self._means(frozen, x, here, loads, edges[2:], d) / (np.pi * self.contact.compliance)
        if slips[0] * slips[1] < 0:
            total = total + 2 * self.friction / np.pi * self._far_zone(-1, x, edges)
        return np.asarray(total)

    def outer_slope(
        self, frozen: Frozen, side: int, x: Array, loads: Array, edges: tuple[Array, Array, Array, Array], slips: tuple[int, int]
    ) -> Array:
        """s' at x (n, m) beyond the stick edge of a side at instants (n,), in the slip zone and outside the contact."""
        eps, (a1, a2, b1, b2), f, A = loads[2, :, None], edges, self.friction, self.contact.compliance
        d = (slips[1] if side > 0 else slips[0]) or slips[0] or slips[1] or 1
        edge = b2 if side > 0 else b1
        at_edge = self._drive(edge[:, None], frozen.slope(edge)[:, None], loads, d)
        root = side * np.sqrt(np.maximum((x - b1[:, None]) * (x - b2[:, None]), 0.0))
        total = -self._means(frozen, x, at_edge + 0 * x, loads, (b1, b2), d)
        if slips[0] * slips[1] < 0:
            total = total - 2 * A * f * side * self._far_zone(-side, x, edges)
        return np.asarray(d * (f * self.contact.beyond(x, a1[:, None], a2[:, None]) - at_edge - root / np.pi * total) - eps)

    # ------------------------------------------------------------------------------------------------------------ a step
    def _instants(self, begin: float, end: float) -> tuple[Array, Array, Array, Array, Array]:
        time = _times(begin, end, self.order)
        loads = self.loads.values(time)
        return time, loads, self.loads.rates(time), *self.contact.edges(loads[0], loads[3])

    def _attempt(self, state: State, slips: tuple[int, int], end: float) -> Step | None:
        """The step up to `end`, by Newton's method; None where that does not converge."""
        self.counts["tries"] += 1
        n, frozen = self.order, state.frozen
        time, loads, rates, a1, a2 = self._instants(state.time, end)
        size, share = float(a2[0] - a1[0]), (time - time[0]) / (time[-1] - time[0])
        b1, b2 = (np.full(n + 1, state.b1) if slips[0] else a1.copy()), (np.full(n + 1, state.b2) if slips[1] else a2.copy())
        # First guesses. Where a contact edge has just stopped to stick, q* has no root there yet, and the stick edge returns at
        # about the speed that the contact edge has. Where the contact recedes, the slip zone is about as wide as it was.
        if slips[0]:
            b1 = b1 if state.slips[0] else b1 + np.maximum(a1[0] - a1, 0)
            b1 = np.maximum(b1, a1 + 0.98 * min(state.b1 - a1[0], 1e-2 * size) + 1e-5 * share * size)
        if slips[1]:
            b2 = b2 if state.slips[1] else b2 - np.maximum(a2 - a2[0], 0)
            b2 = np.minimum(b2, a2 - 0.98 * min(a2[0] - state.b2, 1e-2 * size) - 1e-5 * share * size)
        b1[0], b2[0] = state.stick
        grows, moves = (
            [side for side, d in ((-1, slips[0]), (1, slips[1])) if not d],
            [s for s, d in ((-1, slips[0]), (1, slips[1])) if d],
        )
        first = {side: state.end_slope(side) for side in grows}
        values = np.concatenate([np.full(n, first[side]) for side in grows]) if grows else np.zeros(0)
        d = slips[1] or slips[0] or 1
        # What the step before has left fades over this one: a jump would make s' singular.
        left = self._residual(frozen, loads[:, :1], (a1[:1], a2[:1], b1[:1], b2[:1]), slips)
        left_over = np.concatenate([each * (1 - share[1:]) for each in left])

        def residuals(b1: Array, b2: Array) -> tuple[Array, Array | None]:
            found = np.concatenate(self._residual(frozen, loads[:, 1:], (a1[1:], a2[1:], b1[1:], b2[1:]), slips)) - left_over
            columns = []
            for i, side in enumerate(grows):
                both = np.concatenate(_growing_moments(side, b1, b2))
                found = found - d * (both[:, 0] * first[side] + both[:, 1:] @ values[i * n : (i + 1) * n])
                columns.append(-d * both[:, 1:])
            return found, np.concatenate(columns, axis=1) if columns else None

        step, last, fresh = 1e-8 * size, math.inf, True
        low, high = max(float(frozen.low[0]), state.b1), min(float(frozen.high[-1]), state.b2)
        matrix, before, moved = np.zeros((2, 2, n)), np.zeros(2 * n), np.zeros((2, n))
        with np.errstate(all="ignore"):
            for iteration in range(25):
                self.counts["iterations"] += 1
                found, columns = residuals(b1, b2)
                if not np.all(np.isfinite(found)):
                    return None
                if fresh or grows:
                    for i, side in enumerate((-1, 1)):
                        if side in moves:
                            shifted = (b1.copy(), b2.copy())
                            shifted[i][1:] -= side * step
                            matrix[:, i] = ((residuals(*shifted)[0] - found) / (-side * step)).reshape(2, n)
                else:  # Broyden's update of the matrix of every instant
                    norm = np.sum(moved**2, axis=0)
                    missed = (found - before).reshape(2, n) - np.einsum("ijk,jk->ik", matrix, moved)
                    matrix += np.where(norm > (1e-9 * size) ** 2, missed[:, None] * moved / np.maximum(norm, 1e-300), 0.0)
                before = found
                change = np.zeros((2, n))
                if not grows:
                    (a, b), (c, e), (u, v) = matrix[0], matrix[1], found.reshape(2, n)
                    change = -np.stack([u * e - v * b, a * v - c * u]) / (a * e - b * c)
                else:
                    assert columns is not None  # for the type checker: something grows
                    blocks = [
                        np.concatenate([np.diag(matrix[0, (side + 1) // 2]), np.diag(matrix[1, (side + 1) // 2])]) for side in moves
                    ]
                    try:
                        solved = -np.linalg.solve(np.concatenate([*blocks, columns], axis=1), found)
                    except np.linalg.LinAlgError:
                        return None
                    for i, side in enumerate(moves):
                        change[(side + 1) // 2] = solved[i * n : (i + 1) * n]
                    values = values + solved[len(moves) * n :]
                if not np.all(np.isfinite(change)):
                    return None
                old1, old2 = b1.copy(), b2.copy()
                if slips[0]:
                    b1[1:] = np.maximum(b1[1:] + change[0], np.maximum(a1[1:], low))
                if slips[1]:
                    b2[1:] = np.minimum(b2[1:] + change[1], np.minimum(a2[1:], high))
                crossed = b2 <= b1
                b1, b2 = np.where(crossed, (3 * old1 + old2) / 4, b1), np.where(crossed, (3 * old2 + old1) / 4, b2)
                moved = np.stack([(b1 - old1)[1:], (b2 - old2)[1:]])
                largest = float(np.max(np.abs(moved)))
                fresh = any(np.max(np.abs(moved[(s + 1) // 2] - change[(s + 1) // 2])) > 1e-9 * size for s in moves)
                if (iteration > 7 and largest > 1e-3 * size) or (fresh and iteration > 12):
                    return None
                if not moves or (not fresh and (largest < 1e-12 * size or (iteration > 4 and last / 4 < largest < 1e-9 * size))):
                    break
                last = largest
            else:
                return None
        grown = tuple((side, np.append(first[side], values[i * n : (i + 1) * n])) for i, side in enumerate(grows))
        return Step(slips, time, loads, rates, a1, a2, b1, b2, frozen, grown)

    def _monitors(self, step: Step) -> list[tuple[str, int, Array]]:
        """What is positive while both ends do as they do, (n + 1,) each, with the side."""
        found = []
        for side, d, other in ((-1, *step.slips), (1, *step.slips[::-1])):
            if d:
                found.append(("turn", side, -self._edge_load(side, d, step.opposite, step.rates, step.edges)))
                found.append(("gone", side, step.a2 - step.b2 if side > 0 else step.b1 - step.a1))
            else:
                shear, limit = self._at_contact_edge(side, other, step.rates, step.edges)
                found += [("stick", side, limit - shear), ("stick", side, limit + shear)]
        return found

    def _first_event(self, step: Step) -> tuple[float, str, int, Array] | None:
        """Time, name, side and values of the first monitor that turns negative; the last passage of an old edge before all."""
        found: list[tuple[float, str, int, Array]] = []
        for side, d, edge in ((-1, step.slips[0], -step.b1), (1, step.slips[1], step.b2)):
            marks = side * step.frozen.high[:-1]
            marks = marks[(marks < edge[0] - 3e-7 * step.size) & (marks > np.min(edge))]
            if d and len(marks):
                values = edge - np.max(marks)
                k = int(np.flatnonzero(values < 0)[0])
                share = values[k - 1] / (values[k - 1] - values[k])
                found.append((float(step.time[k - 1] + (step.time[k] - step.time[k - 1]) * share), "pass", side, values))
        if found:
            return min(found, key=lambda each: each[0])
        for name, side, values in self._monitors(step):
            below = np.flatnonzero(values[1:] < 0) + 1
            if len(below) and values[below[0]] < -1e-11 * np.max(np.abs(values)):
                at = np.sin(np.pi * (_first_root(values, int(below[0])) + 1) / 4) ** 2
                found.append((float(step.time[0] + (step.time[-1] - step.time[0]) * at), name, side, values))
        return min(found, key=lambda each: each[0]) if found else None

    def _to_passage(self, state: State, step: Step, event: tuple[float, str, int, Array]) -> Step | None:
        """The step that ends just before an edge passes an old one, by the secant rule between bounds.

        Beyond the old edge s' has another series: a step that goes a little too far is not smooth.
        """
        guess, _, side, values = event
        # The gap that is left: at most 1e-8 of the contact.
        mark, aim = side * ((step.b2 if side > 0 else -step.b1)[0] - values[0]), 5e-9 * step.size
        low, high = state.time, float(step.time[-1])
        known = [(low, float(values[0]) - aim), (high, float(values[-1]) - aim)]
        for _ in range(30):
            new = self._attempt(state, step.slips, guess)
            if new is None:
                high, guess = guess, (low + guess) / 2
                continue
            value = side * float((new.b2 if side > 0 else new.b1)[-1] - mark) - aim
            if abs(value) < 0.9 * aim:
                return new
            low, high = (guess, high) if value > 0 else (low, guess)
            known = [known[-1], (guess, value)]
            (before, was), (now, value) = known
            guess = now - value * (now - before) / (value - was) if value != was else math.inf
            if not low < guess < high:
                guess = (low + high) / 2
            if high - low < 1e-13 * float(step.time[-1] - step.time[0]):
                break
        return None

    # ------------------------------------------------------------------------------------------------ from step to step
    def _finished(self, step: Step, state: State) -> tuple[Step, State]:
        """The step with its work and its breaches of the laws, and the state at its end."""
        self.counts["steps"] += 1
        end, pieces = state, list(state.frozen.pieces)
        for side, values in step.grown:
            edge = side * (step.b2 if side > 0 else step.b1)
            low, high = sorted((float(side * edge[0]), float(side * edge[-1])))
            if high - low > 1e-11 * step.size:
                at = _inverse(_fit(edge), side * Piece.places(low, high, self.order))
                pieces = end.joined(side, low, high, _fit(_value(at, _fit(values))))
                end = State(state.time, (low, end.b2) if side < 0 else (end.b1, high), state.slips, pieces)
        if step.grown:
            pieces = _merged(pieces, 10 * _RESOLVED * self.friction * step.size / self.contact.radius)
        frozen = Frozen(pieces)
        end = State(float(step.time[-1]), (float(step.b1[-1]), float(step.b2[-1])), step.slips, pieces)
        rate_of_time = np.cos(np.pi * _nodes(self.order) / 2) * np.pi / 4 * (step.time[-1] - step.time[0])
        work, wrongs = 0.0, [(0.0, end.b1)]
        for side, d in ((-1, step.slips[0]), (1, step.slips[1])):
            if d:
                x, weight = _zone(step.a1, step.b1) if side < 0 else _zone(step.b2, step.a2)
                rate = self.slip_rate(side, step.slips, x, step.rates, step.edges)
                p = self.contact.pressure(x, step.a1[:, None], step.a2[:, None])
                work += _integral(self.friction * np.sum(weight * p * rate, axis=1) * rate_of_time)
                self.fastest = max(self.fastest, float(np.max(rate)))
                wrongs.append((-float(np.min(rate)) / self.fastest, float(x.flat[np.argmin(rate)])))
        x = end.b1 + (end.b2 - end.b1) * np.linspace(0.01, 0.99, 40)
        edges = (step.a1[-1:], step.a2[-1:], *end.edges)
        reserve = self.shear_reserve(end.frozen, x[None], step.loads[:, -1:], edges, step.slips)[0]
        reserve = reserve * np.sqrt((x - end.b1) * (end.b2 - x))
        limit = 2 * self.friction * self.contact.pressure(x, step.a1[-1], step.a2[-1])
        beyond = np.maximum(-reserve, reserve - limit)
        wrongs.append((float(np.max(beyond) / np.max(limit)) * 2, float(x[np.argmax(beyond)])))
        wrong, where = max(wrongs)
        return replace(step, frozen=frozen, work=work, wrong=wrong, where=where), end

    def _closed(self, state: State, side: int, contact: tuple[Array, Array], loads: Array) -> State:
        """The state whose slip zone of a side has come to rest: its s' is frozen up to the edge of contact."""
        state = state.without_slivers(side)
        edge, end = state.edge(side), float(contact[1 if side > 0 else 0][0])
        low, high = min(edge, end), max(edge, end)
        x = Piece.places(low, high, 2 * self.order)
        values = np.empty(len(x))
        inner = slice(1, None) if side > 0 else slice(None, -1)
        values[inner] = self.outer_slope(state.frozen, side, x[None, inner], loads, (*contact, *state.edges), state.slips)[0]
        values[0 if side > 0 else -1] = state.end_slope(side)
        pieces = state.joined(side, low, high, _fit(values))
        stick = (state.b1, high) if side > 0 else (low, state.b2)
        return State(state.time, stick, (state.slips[0], 0) if side > 0 else (0, state.slips[1]), pieces)

    def _next_slips(self, state: State, turned: set[int]) -> tuple[State, tuple[int, int]]:
        """What both ends do just after an instant; slip zones that come to rest are closed. `turned`: sides of a turning point."""
        now = np.array([state.time])
        loads, rates = self.loads.values(now), self.loads.rates(now + _SOON * self.longest)
        a1, a2 = self.contact.edges(loads[0], loads[3])
        both = float(a1[0]), float(a2[0])

        def edges(of: State) -> tuple[Array, Array, Array, Array]:
            return a1, a2, *of.edges

        goes_on = dict.fromkeys((-1, 1), False)
        for _ in range(3):
            closed = False
            for side in (-1, 1):
                d = state.slips[(side + 1) // 2]
                if not d:
                    continue
                opposite = state.slips[0] * state.slips[1] < 0
                goes_on[side] = side not in turned and float(self._edge_load(side, d, opposite, rates, edges(state))[0]) < 0
                if goes_on[side]:
                    continue
                contact_edge = np.array([[both[(side + 1) // 2]]])
                if float(self.slip_rate(side, state.slips, contact_edge, rates, edges(state))[0, 0]) > 0:
                    raise _broken(state.time, state.edge(side), "a stick edge advances into a zone that slips on")
                state, closed = self._closed(state, side, (a1, a2), loads), True
            if not closed:
                break
        slips = [0, 0]
        for i, side in enumerate((-1, 1)):
            if state.slips[i]:
                slips[i] = state.slips[i]
                continue
            shear, limit = (float(v[0]) for v in self._at_contact_edge(side, state.slips[1 - i], rates, edges(state)))
            if limit >= 0:
                slips[i] = 0 if abs(shear) <= limit else int(math.copysign(1, shear))
                continue
            # The contact recedes: slip goes to where q' is beyond what q/p at the edge would make of p'.
            end, d = np.array([[both[i]]]), state.slips[0] or state.slips[1] or 1
            reserve = float(self.shear_reserve(state.frozen, end, loads, edges(state), state.slips)[0, 0])
            reserve *= math.sqrt(state.b2 - state.b1)
            pressure = math.sqrt(both[1] - both[0]) / (self.contact.compliance * self.contact.radius)
            slips[i] = 1 if shear > d * (1 - reserve / (self.friction * pressure)) * limit else -1
        return state, (slips[0], slips[1])

    def _jump(self, state: State, slips: tuple[int, int], stop: float) -> tuple[Step, State] | None:
        """A step over the instant at which edges leave a stretch without q*, which a loop that closes has left; None for none."""
        if 0 in slips:
            return None
        old = state.frozen.high[:-1]
        old = old[(old > state.b1) & (old < state.b2)]
        first, second = (v.ravel() for v in np.meshgrid(np.append(state.b1, old), np.append(state.b2, old), indexing="ij"))
        order = np.flatnonzero(first < second)
        order = order[np.argsort((first - second)[order])][:40]
        first, second, size = first[order], second[order], state.b2 - state.b1
        for delay in 10.0 ** np.arange(-9, -2):
            time = state.time + delay * self.longest
            if time >= stop:
                return None
            loads = self.loads.values(np.full(len(first), time))
            a1, a2 = self.contact.edges(loads[0], loads[3])
            b1, b2, h = first + 1e-4 * size, second - 1e-4 * size, 1e-8 * size
            found = change = np.zeros((2, len(first)))
            with np.errstate(all="ignore"):
                for _ in range(20):
                    found, right, left = (
                        np.stack(self._residual(state.frozen, loads, (a1, a2, b1 + i, b2 - j), slips))
                        for i, j in ((0.0, 0.0), (h, 0.0), (0.0, h))
                    )
                    (a, c), (b, e) = (right - found) / h, (found - left) / h
                    change = -np.stack([found[0] * e - found[1] * b, a * found[1] - c * found[0]]) / (a * e - b * c)
                    limited = np.clip(np.nan_to_num(change), -0.1 * size, 0.1 * size)
                    b1, b2 = np.maximum(b1 + limited[0], state.b1), np.minimum(b2 + limited[1], state.b2)
                    lost = b2 - b1 < 1e-3 * size
                    b1, b2 = np.where(lost, first, b1), np.where(lost, second, b2)
                solved = np.max(np.abs(found), axis=0) < 1e-8 * self.contact.compliance * self.friction * loads[0]
                solved &= (np.max(np.abs(change), axis=0) < 1e-9 * size) & (b2 - b1 < (1 - 1e-5) * size)
            best: tuple[float, float] | None = None
            for i in np.flatnonzero(solved):
                x = b1[i] + (b2[i] - b1[i]) * np.linspace(0.02, 0.98, 49)
                one = slice(i, i + 1)
                reserve = self.shear_reserve(state.frozen, x[None], loads[:, one], (a1[one], a2[one], b1[one], b2[one]), slips)
                if np.min(reserve) > -_WRONG * np.max(reserve) and (best is None or b2[i] - b1[i] > best[1] - best[0]):
                    best = float(b1[i]), float(b2[i])
            if best is not None:
                self.counts["jumps"] += 1
                return self._held(State(state.time, best, slips, state.frozen.pieces), slips, time)
        return None

    def _held(self, state: State, slips: tuple[int, int], end: float) -> tuple[Step, State]:
        """A short step with edges held."""
        time, loads, rates, a1, a2 = self._instants(state.time, end)
        b1, b2 = (np.full(self.order + 1, each) for each in state.stick)
        return self._finished(Step(slips, time, loads, rates, a1, a2, b1, b2, state.frozen), state)

    def _bridge(self, state: State, slips: tuple[int, int], stop: float, patient: bool) -> tuple[Step, State, set[int]] | None:
        """Edges held up to `stop`, or a turning point, that is near: where a loop closes there they meet a stretch without q*.

        Near is where the loads have next to nothing to do any more, and while `patient` is over a share of the longest step.
        """
        if 0 in slips:
            return None
        time = np.array([state.time, stop])
        loads, (b1, b2) = self.loads.values(time), (np.full(2, each) for each in state.stick)
        first, second = self._residual(state.frozen, loads, (*self.contact.edges(loads[0], loads[3]), b1, b2), slips)
        left = abs(first[1] - first[0]) * (state.b2 - state.b1), abs(second[1] - second[0])
        if max(left) < _CLOSING * self.contact.compliance * self.friction * float(loads[0, 0]):
            self.counts["bridged"] += 1
            return *self._held(state, slips, stop), set()
        if not patient:
            return None
        end = min(stop, state.time + _BRIDGED * self.longest)
        step, _ = self._held(state, slips, end)
        turns = [
            (float(np.interp(0.0, -values, step.time)), side)
            for name, side, values in self._monitors(step)
            if name == "turn" and values[-1] < 0 < values[0]
        ]
        if not turns and stop - state.time > 2e-4 * self.longest:
            return None
        self.counts["bridged"] += 1
        if turns:
            end = max(min(turns)[0], state.time + 1e-9 * self.longest)
        return *self._held(state, slips, end), {min(turns)[1]} if turns else set()

    def run(self, state: State, end: float) -> tuple[list[Step], State]:
        """Steps up to a time, and the state there.

        Raises
        ------
        NotOneStickInterval
            Where stick breaks into several intervals, and where a step does not converge however short it is.
        """
        steps: list[Step] = []
        slips, turned, trial, searched = None, set[int](), self.longest, -math.inf
        while state.time < end - _SOON * self.longest:
            if slips is None:
                state, slips = self._next_slips(state, turned)
                turned = set()
            ahead = self.loads.corners[self.loads.corners > state.time + _SOON * self.longest]
            stop = min(end, float(ahead[0])) if len(ahead) else end
            until = stop if stop - state.time < 1.2 * trial else state.time + trial
            step, event = self._attempt(state, slips, until), None
            if step is not None and (event := self._first_event(step)) is not None and event[1] == "pass":
                step = self._to_passage(state, step, event)
                event = self._first_event(step) if step is not None else None
            rough = max(self._roughness(step), 0.0) if step is not None else math.inf
            if step is not None and rough < _RESOLVED and event is not None and event[0] < step.time[-1] - 1e-11 * self.longest:
                step = self._attempt(state, slips, max(event[0], state.time + 1e-9 * self.longest))
            if step is None or rough >= _RESOLVED:
                trial = min(trial, until - state.time) / 2
                bridged = self._bridge(state, slips, stop, patient=trial <= 1e-4 * self.longest)
                if bridged is not None:
                    step, state, turned = bridged
                elif trial > 1e-4 * self.longest:
                    continue
                elif searched < state.time and (jumped := self._jump(state, slips, stop)) is not None:
                    step, state = jumped
                elif trial > _SHORTEST * self.longest:
                    searched = state.time
                    continue
                else:
                    raise NotOneStickInterval(
                        f"load: the edges of stick could not be followed past time {state.time:.6g}, where the engine has no state "
                        "for them; with bulk stress and tilt in phase with the loads it has more often, finite elements take any"
                    )
                trial = self.longest / 16
            else:
                step, state = self._finished(step, state)
                if event is not None:
                    turned = {event[2]} if event[1] == "turn" else set()
                    if event[1] == "gone":
                        i, edge = (event[2] + 1) // 2, float((step.a2 if event[2] > 0 else step.a1)[-1])
                        stick = (state.b1, edge) if i else (edge, state.b2)
                        state = State(state.time, stick, (slips[0], 0) if i else (0, slips[1]), state.frozen.pieces)
                trial = min(self.longest, 2 * trial)
            slips = None  # a load may turn round right where a step ends
            if step.wrong > _WRONG:
                raise _broken(float(step.time[-1]), step.where, "friction would be broken inside what slips or sticks")
            steps.append(step)
        return steps, state

    def _roughness(self, step: Step) -> float:
        """What the last coefficients of edges and of s' leave unresolved, in half-widths."""
        size, slope = step.size / 2, self.friction * step.size / self.contact.radius
        series = [(step.b1, size), (step.b2, size), *((values, slope) for _, values in step.grown)]
        return max(float(np.max(np.abs(_fit(values)[-2:]))) / scale for values, scale in series)


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


def remainder_of(works: Sequence[float]) -> float:
    """How far the work of the last cycle may be from that of the steady one, from the trend of the changes.

    Geometric where changes fall to less than half from cycle to cycle. Where they fall more slowly, like k^-4: k/3 times the last.

    >>> round(remainder_of([1.5, 1.05, 1.005]), 12)  # W falls to 1
    0.005
    >>> works = [1 + k**-3.0 for k in range(1, 41)]  # 1.6e-5 is left
    >>> 1e-5 < remainder_of(works) < 3e-5
    True
    """
    changes = np.abs(np.diff(works))
    if len(changes) < 2 or changes[-1] == 0:
        return float(changes[-1]) if len(changes) else math.inf
    ratio = float(changes[-1] / changes[-2]) if changes[-2] > 0 else 1.0
    if ratio < 0.5:
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
    latest = float(np.max(time)) if time is not None and len(time) else path.cycle_start
    needed = 1 if period is None else max(1, math.ceil((latest - path.cycle_start) / period - 1e-9))
    most = max(most, needed)
    longest = (period if period is not None else path.cycle_start - path.start) / 16
    state = _touched(loads, contact, first.start + 1e-4 * (first.end - first.start))
    follower = Follower(contact, friction, Loads(loads.values, loads.rates, loads.corners(most)), longest)
    steps, state = follower.run(state, path.cycle_start)
    last, works = steps, [math.fsum(step.work for step in steps)] if period is None else []
    while period is not None and len(works) < most:
        last, state = follower.run(state, path.cycle_start + (len(works) + 1) * period)
        steps = [*steps, *last]
        works.append(math.fsum(step.work for step in last))
        if len(works) >= max(needed, 2) and abs(works[-1] - works[-2]) <= STEADY * works[-1]:
            break
    loop = math.fsum(_loop_of(follower, step) for step in last)
    if period is not None:
        loop = _agreeing(works[-1], loop, contact.compliance * (friction * float(np.max(last[0].loads[0]))) ** 2)
    changes = np.abs(np.diff(works)) <= STEADY * np.array(works[1:])
    steady = int(np.flatnonzero(changes)[0]) + 1 if np.any(changes) else None
    instants = np.unique(np.concatenate([step.time[::2] for step in steps])) if time is None else np.asarray(time, dtype=float)
    given, moment, shear_moment, displacement, contact_edges, stick_edges, pressure, shear, slip, state_of = _at(
        follower, steps, instants, x
    )
    low, high = max(float(np.max(step.b1)) for step in last), min(float(np.min(step.b2)) for step in last)
    return Followed(
        time=instants,
        loads=given,
        moment=moment,
        shear_moment=shear_moment,
        displacement=displacement,
        contact_edges=contact_edges,
        stick_edges=stick_edges,
        pressure=pressure,
        shear=shear,
        slip=slip,
        state=state_of.astype(np.int8),
        works=np.array(works),
        loop=loop,
        remainder=remainder_of(works),
        steady_from=steady,
        steady_to=STEADY,
        density=np.sum([_density_of(follower, step, x) for step in last], axis=0),
        permanent_stick_edges=np.array([low, high] if low < high else [math.nan, math.nan]),
        counts=dict(follower.counts),
        errors=dict.fromkeys(("dissipation", "dissipation_density", "shear", "slip"), ERROR),
    )


def _touched(loads: PathLoads, contact: Parabola, time: float) -> State:
    """The state of a contact that has just begun, q = (Q/P) p: what bulk and tilt change of it so far is below 1e-6 of the end."""
    p, q, eps, alpha = loads.values(np.array([time]))[:, 0].tolist()
    a1, a2 = (float(edge) for edge in contact.edges(np.array(p), np.array(alpha)))
    series = _fit(q / p * (contact.slope(Piece.places(a1, a2, ORDER)) + alpha) - eps)
    piece = Piece(a1, a2, series)
    piece.begin = -float(piece.slip_at(0.0))
    return State(time, (a1, a2), (0, 0), [piece])


def _displacement(follower: Follower, step: Step, loads: Array, edges: tuple[Array, Array, Array, Array]) -> tuple[Array, Array]:
    """U and m_q at instants of a step, (n,) each: from the means of the equations of stick over 1/w."""
    (_, Q, eps, _), (a1, a2, b1, b2), A = loads, edges, follower.contact.compliance
    m, c = (b1 + b2) / 2, (b2 - b1) / 2
    _, _, second, slip = step.frozen.moments(b1, b2, slip=True)
    U = slip / np.pi + eps * m - A / np.pi * Q * np.log(c / 2)
    moment = m * Q + (second + eps * np.pi * c**2 / 2) / A
    for side, d in ((-1, step.slips[0]), (1, step.slips[1])):
        if d:
            x, weight = _zone(a1, b1) if side < 0 else _zone(b2, a2)
            zeta = x - m[:, None]
            q = d * follower.friction * weight * follower.contact.pressure(x, a1[:, None], a2[:, None])
            w = _root_beyond(np.abs(zeta), c[:, None])
            U = U - A / np.pi * np.sum(q * np.arccosh(np.maximum(np.abs(zeta) / c[:, None], 1.0)), axis=1)
            moment = moment + side * np.sum(q * zeta**2 / w, axis=1)
    return U, moment


def _loop_of(follower: Follower, step: Step) -> float:
    """Integral of Q dU - m_q d eps over a step."""
    U, moment = _displacement(follower, step, step.loads, step.edges)
    nodes = _nodes(follower.order)
    dU, deps = (_value(nodes, _slope(_fit(each))) for each in (U, step.loads[2]))
    return _integral(step.loads[1] * dU - moment * deps)


def _at(follower: Follower, steps: Sequence[Step], time: Array, x: Array) -> tuple[Array, ...]:
    """Everything at instants (n,), in the order of `Followed`."""
    n, m = len(time), len(x)
    loads, edges, (U, shear_moment), fields = np.zeros((4, n)), np.zeros((4, n)), np.zeros((2, n)), np.zeros((4, n, m))
    ends = np.array([each.time[-1] for each in steps])
    number = np.minimum(np.searchsorted(ends, time - _SOON * follower.longest), len(steps) - 1)
    before = time < steps[0].time[0]  # out of contact, but for the last 1e-4 of the load that touches first
    for k in np.flatnonzero(before):
        loads[:, k] = np.nan_to_num(follower.loads.values(time[k : k + 1])[:, 0])
        fields[2, k] = -loads[2, k] * x
    fields[3, before] = OPEN
    for k in np.unique(number[~before]):
        whole = np.flatnonzero((number == k) & ~before)
        for some in np.array_split(whole, -(-len(whole) // _TOGETHER)):
            four = _edges_at(follower, steps[k], time[some])
            loads[:, some], edges[:, some] = four[0], four[1]
            U[some], shear_moment[some] = _displacement(follower, steps[k], four[0], four[1])
            fields[:, some] = _fields(follower, steps[k], four[0], four[1], x)
    moment = loads[0] * (edges[0] + edges[1]) / 2
    return loads, moment, shear_moment, U, edges[:2].T, edges[2:].T, *fields


def _edges_at(follower: Follower, step: Step, time: Array) -> tuple[Array, tuple[Array, Array, Array, Array]]:
    """Loads (4, n), and a1, a2, b1, b2 at instants of a step."""
    inside = np.clip(time, step.time[0], step.time[-1])
    loads, phi = follower.loads.values(inside), step.phi(inside)
    a1, a2 = follower.contact.edges(loads[0], loads[3])
    b1 = np.maximum(_value(phi, _fit(step.b1)), a1) if step.slips[0] else a1
    b2 = np.minimum(_value(phi, _fit(step.b2)), a2) if step.slips[1] else a2
    return loads, (a1, a2, b1, b2)


def _fields(follower: Follower, step: Step, loads: Array, edges: tuple[Array, Array, Array, Array], x: Array) -> Array:
    """p, q, s and the state of the surface at points (m,) and instants (n,) of a step: (4, n, m)."""
    f, d, n = follower.friction, step.slips[1] or step.slips[0] or 1, 2 * follower.order
    a1, a2, b1, b2 = (edge[:, None] for edge in edges)
    p = follower.contact.pressure(x, a1, a2)
    touching, sticks = (x >= a1) & (x <= a2), (x >= b1) & (x <= b2)
    q, s = f * p * np.where(x > b2, step.slips[1], step.slips[0]), np.zeros(p.shape)
    state = np.where(sticks, STICK, np.where(touching, np.where(q > 0, SLIP_FORWARD, SLIP_REVERSE), OPEN))
    here = np.where(sticks, x, (b1 + b2) / 2)
    reserve = follower.shear_reserve(step.frozen, here, loads, edges, step.slips) * np.sqrt((here - b1) * (b2 - here))
    q, s = np.where(sticks, d * (f * p - reserve), q), step.frozen.slip(here.ravel()).reshape(p.shape)
    for side, begin, middle in ((-1, b1, a1), (1, b2, a2)):
        far = np.maximum(middle, np.max(x)) if side > 0 else np.minimum(middle, np.min(x))
        at_begin, share = step.frozen.slip(begin[:, 0])[:, None], (_nodes(n) + 1) / 2
        for first, last in ((begin, middle), (middle, far)):
            way = last - first
            slope = np.zeros((len(way), n + 1))  # not used where the way begins: x stands still there
            there = first + way * share[1:] ** 2
            slope[:, 1:] = follower.outer_slope(step.frozen, side, there, loads, edges, step.slips)
            rise = _primitive(_fit(np.where(side * way > 1e-12 * step.size, slope * share * way, 0.0).T))[..., None]
            passed = np.clip((x - first) / np.where(way != 0, way, 1.0), 0, 1)
            between = (side * (x - first) > 0) & (side * (x - last) <= 0)
            s = np.where(between, at_begin + chebyshev.chebval(2 * np.sqrt(passed) - 1, rise, tensor=False), s)
            at_begin = at_begin + chebyshev.chebval(np.ones(1), rise, tensor=False)
    return np.stack([p, np.where(touching, q, 0.0), s, state])


def _density_of(follower: Follower, step: Step, x: Array) -> Array:
    """Friction work at points (k,) over a step: f p |ds/dt| over the time that each is in a slip zone."""
    found, fine = np.zeros(len(x)), np.linspace(-1, 1, 65)
    duration, series = step.time[-1] - step.time[0], [_fit(each) for each in step.edges]
    for side, d in ((-1, step.slips[0]), (1, step.slips[1])):
        if not d:
            continue
        outer, inner = (series[1], series[3]) if side > 0 else (series[0], series[2])

        def depth(phi: Array, at: Array, side: int = side, outer: Array = outer, inner: Array = inner) -> Array:
            """Distance from the nearer end of the slip zone, positive within it."""
            return np.minimum(side * (at - _value(phi, inner)), side * (_value(phi, outer) - at))

        inside = depth(fine[:, None], x)
        for k in np.flatnonzero(np.max(inside, axis=0) > 0):
            turns = np.flatnonzero((inside[1:, k] > 0) != (inside[:-1, k] > 0))
            marks = [-1.0, *(float(brentq(depth, fine[j], fine[j + 1], args=(x[k],), xtol=1e-14)) for j in turns), 1.0]
            for begin, end in pairwise(marks):
                angle = begin + (end - begin) * np.sin(_ANGLE / 2) ** 2
                if np.min(depth(angle, x[k])) <= 0:
                    continue
                weight = (end - begin) / 2 * np.sin(_ANGLE) * _ANGLE_WEIGHT
                a1, a2, b1, b2 = (_value(angle, each) for each in series)
                time = step.time[0] + duration * np.sin(np.pi * (angle + 1) / 4) ** 2
                points, rates = np.full((len(time), 1), x[k]), follower.loads.rates(time)
                rate = follower.slip_rate(side, step.slips, points, rates, (a1, a2, b1, b2))[:, 0]
                p = follower.contact.pressure(np.array(x[k]), a1, a2)
                found[k] += np.sum(weight * np.cos(np.pi * angle / 2) * np.pi / 4 * duration * follower.friction * p * rate)
    return found
