"""What every pile of flat punches answers by quadrature, given only P(a), its slope and its inverse; with an honest error estimate.

# notation: a half-width, alpha half-width of a punch in the pile, g = dP/da, P or eta normal load, P_x load at which a = |x|

    p = (1/pi) int g/sqrt(alpha^2 - x^2) d alpha    S = int g arccosh(|x|/alpha) d alpha    Lam = int_c^a g ln(alpha/c) d alpha

Profiles that know a closed form override the method.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
_CLOSE = 0.01
_NEARBY = 0.3
_STEP = 0.375
_CHUNK = 4_000_000


class Rule(NamedTuple):
    """Trapezoidal rule in s of 1/(1 + exp(-s)) on [0, 1]: distances from both ends, weights."""

    up: Array
    down: Array
    share: Array


def _rule(low: float, high: float) -> Rule:
    s = np.arange(low, high + _STEP / 2, _STEP)
    up, down = 1 / (1 + np.exp(-s)), 1 / (1 + np.exp(s))
    return Rule(up, down, _STEP * up * down)


ROOTS = _rule(-36.0, 36.0)
"""For roots and logarithms at the ends."""

INVERSE_ROOT = _rule(-75.0, 36.0)
"""For an inverse root at the lower end too."""


class Nodes(NamedTuple):
    """Nodes of panels between `begin` and `end`, distances from both without cancellation, weights: (..., panels, nodes)."""

    at: Array
    above: Array
    below: Array
    weight: Array


def panels(begin: ArrayLike, end: ArrayLike, breaks: Iterable[ArrayLike] = (), rule: Rule = ROOTS) -> Nodes:
    """A rule for singular ends on [begin, end], cut at those of `breaks` (ascending, arrays like `end`) that lie inside."""
    first, last = np.broadcast_arrays(np.asarray(begin, dtype=float), np.asarray(end, dtype=float))
    inside = [b for b in breaks if np.any((first < b) & (b < last))]
    marks = [first, *(np.clip(b, first, last) for b in inside), last]
    low, high = np.stack(marks[:-1], axis=-1)[..., None], np.stack(marks[1:], axis=-1)[..., None]
    length = high - low
    up, down = length * rule.up, length * rule.down
    above = (low - first[..., None, None]) + up
    below = (last[..., None, None] - high) + down
    return Nodes(np.where(rule.up < 0.5, low + up, high - down), above, below, length * rule.share)


class Terms(NamedTuple):
    """Summands of a quadrature, (..., panels, nodes)."""

    parts: Array

    def total(self) -> Array:
        """The integral."""
        return np.sum(self.parts, axis=(-2, -1))

    def error(self) -> Array:
        """An estimate from above: the rule with half the nodes, whose error is about the root of the full rule's, and rounding."""
        fine = self.total()
        coarse = 2 * np.sum(self.parts[..., ::2], axis=(-2, -1))
        size = np.sum(np.abs(self.parts), axis=(-2, -1))
        safe = np.where(size > 0, size, 1.0)
        return size * (np.minimum(np.abs(fine - coarse) / safe, 1.0) ** 1.5 + 50 * _EPS)


def in_chunks(function: Callable[[Array, Array], Array], one: ArrayLike, other: ArrayLike, nodes: int) -> Array:
    """The function over broadcast arguments, a bounded number of nodes at a time."""
    first, second = np.broadcast_arrays(np.asarray(one, dtype=float), np.asarray(other, dtype=float))
    shape, count = first.shape, max(_CHUNK // max(nodes, 1), 1)
    if first.size <= count:
        return np.asarray(function(first, second))
    flat, flat_too = first.ravel(), second.ravel()
    parts = [function(flat[k : k + count], flat_too[k : k + count]) for k in range(0, flat.size, count)]
    return np.concatenate(parts).reshape(shape)


def rising_root(function: Callable[[Array], Array], slope: Callable[[Array], Array], value: Array, guess: Array) -> Array:
    """The x > 0 at which a rising function has a `value` >= 0, to rounding: Newton's method between logarithms.

    >>> float(rising_root(lambda x: x**3, lambda x: 3 * x**2, np.array(8.0), np.array(1.0)))
    2.0
    """
    wanted = np.where(value > 0, value, 1.0)
    x = np.where(value > 0, guess, 1.0)
    for _ in range(60):
        now = function(x)
        steepness = x * slope(x) / np.where(now > 0, now, 1.0)
        step = np.log(wanted / np.where(now > 0, now, wanted)) / np.where(steepness > 0, steepness, 1.0)
        x = x * np.exp(np.clip(step, -3.0, 3.0))
        if np.all(np.abs(step) < 4 * _EPS):
            break
    else:
        # The last digit may go back and forth for ever: that is rounding. More is not.
        x = np.where(np.abs(step) < 1e-11, x, np.nan)
    return np.where(value > 0, x, 0.0)


@dataclass(frozen=True)
class Pile:
    """The methods of `Contact` by quadrature. A profile gives `load`, `half_width` and `stiffness`, and where that has corners."""

    modulus: float
    datum_length: float

    @abstractmethod
    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness], 0 below the least half-width."""

    @abstractmethod
    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]."""

    @abstractmethod
    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da >= 0 [stress]."""

    @property
    def least(self) -> float:
        """a for P = 0 [length]."""
        return 0.0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Half-widths at which dP/da is not smooth."""
        return ()

    @property
    def noise(self) -> float:
        """Relative error of P and dP/da themselves."""
        return 2 * _EPS

    def _weight(self, at: Array, order: int) -> Array:
        return self.stiffness(at) * self.load(at) if order else self.stiffness(at)

    def _pressure_terms(self, x: Array, load: Array, order: int = 0) -> Terms:
        distance, half = np.abs(x), self.half_width(load)
        first = np.maximum(distance, self.least)
        node = panels(first, np.maximum(half, first), self.breaks, INVERSE_ROOT)
        beyond = (first - distance)[..., None, None] + node.above
        root = np.sqrt(beyond * (node.at + distance[..., None, None]))
        return Terms(node.weight * self._weight(node.at, order) / np.where(root > 0, root, np.inf) / np.pi)

    def _spread_terms(self, x: Array, load: Array, order: int = 0) -> Terms:
        distance, half = np.abs(x), self.half_width(load)
        last = np.maximum(np.minimum(half, distance), self.least)
        node = panels(self.least, last, self.breaks)
        gap = np.maximum((distance - last)[..., None, None] + node.below, 0.0) * (distance[..., None, None] + node.at)
        reach = np.arcsinh(np.sqrt(gap) / np.where(node.at > 0, node.at, np.inf))
        return Terms(node.weight * self._weight(node.at, order) * reach)

    def _log_terms(self, load: Array, order: int = 0) -> Terms:
        """int_0^a P^(order + 1)/alpha d alpha: what is left of the logarithm after integrating by parts."""
        node = panels(self.least, self.half_width(load), self.breaks)
        return Terms(node.weight * self.load(node.at) ** (order + 1) / np.where(node.at > 0, node.at, np.inf))

    def _area_terms(self, load: Array, slipped: Array, order: int = 0) -> Terms:
        del order
        half = self.half_width(load)
        drop = self._drop(half, load, slipped)
        front = np.maximum(half - drop, 0.0)
        node = panels(0.0, drop, [b - front for b in self.breaks])
        at = front[..., None, None] + node.at
        safe = np.where(front > 0, front, np.finfo(float).tiny)[..., None, None]
        near = node.at < safe
        growth = np.where(near, np.log1p(np.where(near, node.at, 0.0) / safe), np.log(np.maximum(at, safe)) - np.log(safe))
        return Terms(node.weight * self.stiffness(at) * growth)

    def _drop(self, half: Array, load: Array, slipped: Array) -> Array:
        """a(P) - a(P - slipped), free of cancellation: Newton's method on the load between the two where they are close."""
        direct = half - self.half_width(np.maximum(load - slipped, 0.0))
        close = (slipped < _NEARBY * load) & (slipped > 0)
        if not np.any(close):
            return direct
        a, wanted = half[close], slipped[close]
        drop = np.maximum(direct[close], wanted / self.stiffness(a) * 0.5)
        for _ in range(4):
            node = panels(0.0, drop, [a - b for b in self.breaks[::-1]])
            fault = np.sum(node.weight * self.stiffness(a[..., None, None] - node.at), axis=(-2, -1)) - wanted
            drop = np.maximum(drop - fault / self.stiffness(a - drop), 0.1 * drop)
        result = np.array(direct)
        result[close] = drop
        return result

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Estimated error of the method `name` for these arguments, where it is done by quadrature; not below the true one."""
        terms, order = {
            "pressure": (self._pressure_terms, 0),
            "spread": (self._spread_terms, 0),
            "log_distance": (self._log_terms, 0),
            "log_area": (self._area_terms, 0),
            "pressure_moment": (self._pressure_terms, 1),
            "spread_moment": (self._spread_terms, 1),
            "log_moment": (self._log_terms, 1),
        }[name]
        values = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in arguments))
        found = terms(*values, order)  # type: ignore[operator]
        half = self.half_width(values[-1] if name != "log_area" else values[0])
        # What the last digit of a half-width does to the result, and errors of P(a).
        near = {"pressure": half - np.abs(values[0]), "spread": np.abs(values[0]) - half}.get(name.removesuffix("_moment"), half)
        if name == "log_area":
            near = self._drop(half, *values)
        last_digit = 8 * _EPS * half / np.maximum(np.abs(near), _EPS * np.maximum(half, np.finfo(float).tiny))
        return found.error() + (last_digit + self.noise) * np.sum(np.abs(found.parts), axis=(-2, -1))

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        return in_chunks(lambda at, p: self._pressure_terms(at, p).total(), x, load, self._nodes)

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load]."""
        return in_chunks(lambda at, p: self._pressure_terms(at, p, 1).total(), x, load, self._nodes)

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]."""
        return in_chunks(lambda at, p: self._spread_terms(at, p).total(), x, load, self._nodes)

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x)."""
        return in_chunks(lambda at, p: self._spread_terms(at, p, 1).total(), x, load, self._nodes)

    @property
    def _nodes(self) -> int:
        return len(INVERSE_ROOT.up) * (len(self.breaks) + 1)

    def _mean_rate(self, low: Array, high: Array) -> Array:
        """(P(high) - P(low))/(high^2 - low^2) for low, high as close as may be."""
        start = np.maximum(low, self.least)
        width = np.maximum(high - start, 4 * _EPS * high)
        node = panels(0.0, width, [b - start for b in self.breaks])
        at = start[..., None, None] + node.at
        return np.sum(node.weight * self.stiffness(at), axis=(-2, -1)) / np.sum(node.weight * 2 * at, axis=(-2, -1))

    def _square_gap(self, low: Array, high: Array, rise: Array) -> Array:
        """high^2 - low^2 from the rise of P between them where they are close."""
        gap = np.array((high - low) * (high + low))
        close = gap < _CLOSE * np.square(high)
        if np.any(close):
            rate = self._mean_rate(low[close], high[close])
            gap[close] = rise[close] / np.where(rate > 0, rate, np.inf)
        return gap

    def reach(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) = arsinh(sqrt(x^2 - a^2)/a), from eta and P_x - eta >= 0; 0 is returned for eta = 0 and a = 0."""
        distance, rise, p = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (np.abs(x), excess, load)))
        low = self.half_width(p)
        gap = self._square_gap(low, np.maximum(distance, low), rise)
        return np.arcsinh(np.sqrt(gap) / np.where(low > 0, low, np.inf))

    def root_quotient(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """sqrt((eta - P_x)/(a(eta)^2 - x^2)) from eta and eta - P_x > 0."""
        distance, rise, p = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in (np.abs(x), excess, load)))
        high = self.half_width(p)
        low = np.minimum(distance, high)
        rate = np.array(rise / np.maximum((high - low) * (high + low), np.finfo(float).tiny))
        close = (low >= self.least) & ((high - low) * (high + low) < _CLOSE * np.square(high))
        if np.any(close):
            rate[close] = self._mean_rate(low[close], high[close])
        return np.sqrt(rate)

    def log_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P)); that of the smallest number for a = 0, where it is multiplied by P."""
        return np.log(2 * self.datum_length) - np.log(np.maximum(self.half_width(load), np.finfo(float).tiny))

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta = P ln(2 L/a) + int_0^a P/alpha d alpha [force per thickness]."""
        p = np.asarray(load, dtype=float)
        return p * self.log_ratio(p) + self._log_terms(p).total()

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta = (P^2 ln(2 L/a) + int_0^a P^2/alpha d alpha)/2."""
        p = np.asarray(load, dtype=float)
        return (p * p * self.log_ratio(p) + self._log_terms(p, 1).total()) / 2

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) = int_{P_c}^P ln(a(eta)/a(P_c)) d eta from P and P - P_c."""
        return in_chunks(lambda p, d: self._area_terms(p, d).total(), load, slipped, self._nodes)
