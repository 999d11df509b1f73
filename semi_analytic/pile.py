"""What every pile of flat punches answers by quadrature, given only P(a), its slope and its inverse; with an honest error estimate.

# notation: a half-width, alpha half-width of a punch in the pile, g = dP/da, P or eta normal load, P_x load at which a = |x|

    p = (1/pi) int g/sqrt(alpha^2 - x^2) d alpha    S = int g arccosh(|x|/alpha) d alpha    Lam = int_c^a g ln(alpha/c) d alpha

Profiles that know a closed form override the method.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semi_analytic.panels import CHUNK, panels
from semi_analytic.quadrature import ROOTS, gauss
from semi_analytic.sheets import OCTAVES, Kind, Sheet, sheet_of

Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
_ROOT_OF_ROUNDING = 3e-9
_CLOSE = 0.01
_NEARBY = 0.3
_APART = 0.02
_REMEMBERED = 8


def rising_root(function: Callable[[Array], Array], slope: Callable[[Array], Array], value: Array, guess: Array) -> Array:
    """The x > 0 at which a rising function has a `value` >= 0, to rounding: Newton's method between logarithms.

    Arrays of one shape; 0 for a value of 0, NaN where 60 steps do not find it.

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
        # The next step would be about the square of this one.
        if np.all(np.abs(step) < _ROOT_OF_ROUNDING):
            break
    else:
        x = np.where(np.abs(step) < _ROOT_OF_ROUNDING, x, np.nan)
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
    def bends_anywhere(self) -> bool:
        """Whether P may hardly grow anywhere between the corners, so that a(P) is all but steep there."""
        return False

    @property
    def noise(self) -> float:
        """Relative error of P and dP/da themselves."""
        return 2 * _EPS

    @cached_property
    def _begins(self) -> Array:
        """Half-widths from a(0) up behind which P and dP/da are one smooth function each of sqrt(a - begin)."""
        return np.array([self.least, *self.breaks])

    @cached_property
    def _break_loads(self) -> Array:
        return np.asarray(self.load(self._begins))

    @cached_property
    def _sheets(self) -> dict[tuple[Kind, int], list[Sheet]]:
        """What was integrated for earlier questions: nothing but a memory of answers."""
        return {}

    def _sheet(self, kind: Kind, order: int, x: Array, top: float) -> tuple[Sheet, NDArray[np.intp]]:
        """A sheet that reaches `top` and holds the points `x`, and their numbers on it."""
        known = self._sheets.setdefault((kind, order), [])
        for sheet in known:
            number = np.minimum(np.searchsorted(sheet.x, x), len(sheet.x) - 1)
            if top <= sheet.top < top * 2.0 ** (OCTAVES // 2) and np.array_equal(sheet.x[number], x):
                return sheet, number
        sheet = sheet_of(kind, x, top, self._begins, (self.load, self.stiffness), order)
        known[:] = [sheet, *known[: _REMEMBERED - 1]]
        return sheet, np.arange(len(x))

    def _integral(self, kind: Kind, order: int, x: Array, half: Array) -> tuple[Array, Array]:
        """The integral of a kind at `x` up to `half`, arrays that broadcast, and its error."""
        different, fold = np.unique(np.ravel(x), return_inverse=True)
        top = float(np.max(half, initial=self.least))
        if top <= self.least:
            nothing = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(half)))
            return nothing, nothing
        sheet, number = self._sheet(kind, order, different, top)
        point, upto = np.broadcast_arrays(number[fold].reshape(np.shape(x)), half)
        return sheet(point, upto)

    def _of_points(self, kind: Kind, order: int, x: ArrayLike, load: ArrayLike) -> tuple[Array, Array]:
        """Pressure or spread, and the error of the series."""
        distance, p = np.abs(np.asarray(x, dtype=float)), np.asarray(load, dtype=float)
        half = self.half_width(p)
        value, error = self._integral(kind, order, distance, half)
        if kind == "spread":
            inner = np.minimum(half, distance)
            force = np.minimum(p, self.load(distance))
            root = np.sqrt((distance - inner) * (distance + inner))
            reach = np.arcsinh(root / np.where(inner > 0, inner, np.inf))
            value = value + (force * force / 2 if order else force) * reach
        else:
            value = np.where(distance < half, value, 0.0)
        return np.maximum(value, 0.0), error

    def _logarithm(self, order: int, half: Array) -> tuple[Array, Array]:
        """int_0^a P/alpha d alpha, of order 1 int_0^a P^2/(2 alpha) d alpha, and the error."""
        value, error = self._integral("logarithm", order, np.zeros(1), half.reshape(-1, 1))
        return value.reshape(half.shape), error.reshape(half.shape)

    def quadrature_error(self, name: str, *arguments: ArrayLike) -> Array:
        """Estimated error of the method `name` for these arguments, where it is done by quadrature; not below the true one."""
        values = np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in arguments))
        order, kind = int(name.endswith("_moment")), name.removesuffix("_moment")
        half = self.half_width(values[0] if name == "log_area" else values[-1])
        if kind in ("pressure", "spread"):
            value, left = self._of_points("pressure" if kind == "pressure" else "spread", order, *values)
            near = np.abs(half - np.abs(values[0])) if kind == "pressure" else np.minimum(half, np.abs(values[0])) - self.least
        elif name == "log_area":
            load, slipped = values
            value, left = Pile.log_area(self, load, slipped), self._logarithm(0, half)[1]
            # Far apart it is a difference of larger numbers; close together the last digit of P counts.
            left = left + 8 * _EPS * load * (1 + np.abs(np.log(np.maximum(half, _EPS))))
            near = np.abs(half - self.half_width(load - slipped))
        else:
            value, left = self._logarithm(order, half)
            value, near = value + np.abs(values[0]) ** (1 + order) * np.abs(self.log_ratio(values[0])), half
        # What the last digit of a half-width does to the result, and errors of P(a).
        last_digit = 8 * _EPS * half / np.maximum(near, _EPS * np.maximum(half, np.finfo(float).tiny))
        return left + (last_digit + self.noise + 50 * _EPS) * np.abs(value)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress], 0 outside the contact."""
        return self._of_points("pressure", 0, x, load)[0]

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta) [stress * load]."""
        return self._of_points("pressure", 1, x, load)[0]

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x) [force per thickness]."""
        return self._of_points("spread", 0, x, load)[0]

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x)."""
        return self._of_points("spread", 1, x, load)[0]

    def _mean_rate(self, low: Array, high: Array) -> Array:
        """(P(high) - P(low))/(high^2 - low^2) for low, high as close as may be: in two parts if there is a corner in between."""
        start = np.maximum(low, self.least)
        end = np.maximum(high, start * (1 + 4 * _EPS))
        number = np.searchsorted(self._begins, start, side="right") - 1
        corner = np.append(self._begins, np.inf)[number + 1]
        above, below = np.zeros(start.shape), np.zeros(start.shape)
        for first, last, behind in ((start, np.minimum(corner, end), number), (np.minimum(corner, end), end, number + 1)):
            b = self._begins[np.minimum(behind, len(self._begins) - 1)]
            inner, outer = np.sqrt(np.maximum(first - b, 0.0)), np.sqrt(np.maximum(last - b, 0.0))
            node, share = gauss(6)
            root = inner[..., None] + (outer - inner)[..., None] * node
            at = b[..., None] + root * root
            weight = (outer - inner)[..., None] * share * root
            above = above + np.sum(weight * self.stiffness(at), axis=-1)
            below = below + np.sum(weight * 2 * at, axis=-1)
        return above / np.where(below > 0, below, 1.0)

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
        gap = (high - low) * (high + low)
        rate = np.array(rise / np.where(gap > 0, gap, np.inf))
        close = (low >= self.least) & (gap < _CLOSE * np.square(high))
        if np.any(close):
            rate[close] = self._mean_rate(low[close], high[close])
        return np.sqrt(rate)

    def log_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P)); that of the smallest number for a = 0, where it is multiplied by P."""
        return np.log(2 * self.datum_length) - np.log(np.maximum(self.half_width(load), np.finfo(float).tiny))

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta = P ln(2 L/a) + int_0^a P/alpha d alpha [force per thickness]."""
        p = np.asarray(load, dtype=float)
        return p * self.log_ratio(p) + self._logarithm(0, self.half_width(p))[0]

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta = P^2 ln(2 L/a)/2 + int_0^a P^2/(2 alpha) d alpha."""
        p = np.asarray(load, dtype=float)
        return p * p * self.log_ratio(p) / 2 + self._logarithm(1, self.half_width(p))[0]

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) = int_{P_c}^P ln(a(eta)/a(P_c)) d eta from P and P - P_c.

        Far apart P ln(a/c) less the rise of int P/alpha; close together int (P - eta) d ln(a), by Gauss' rule where that is smooth.
        """
        p, d = np.broadcast_arrays(np.asarray(load, dtype=float), np.asarray(slipped, dtype=float))
        front = np.maximum(p - d, 0.0)
        number = np.maximum(np.searchsorted(self._break_loads, front, side="right") - 1, 0)
        smooth = (d < _NEARBY * (front - self._break_loads[number])) & (p <= np.append(self._break_loads, np.inf)[number + 1])
        far = ~smooth & (d > _APART * p)
        between = ~smooth & ~far & (d > 0)
        result = np.zeros(p.shape)
        for here, function in ((smooth, self._area_nearby), (far, self._area_apart), (between, self._area_across)):
            if np.any(here):
                result[here] = function(p[here], d[here])
        return result

    def _area_nearby(self, load: Array, slipped: Array) -> Array:
        node, weight = gauss(12)
        eta = (load - slipped)[:, None] + slipped[:, None] * node
        half = self.half_width(eta)
        return np.square(slipped) * np.sum(weight * (1 - node) / (half * self.stiffness(half)), axis=-1)

    def _area_apart(self, load: Array, slipped: Array) -> Array:
        half, front = self.half_width(load), self.half_width(np.maximum(load - slipped, 0.0))
        ratio = np.log(half / np.where(front > 0, front, np.finfo(float).tiny))
        return load * ratio - (self._logarithm(0, half)[0] - self._logarithm(0, front)[0])

    def _area_across(self, load: Array, slipped: Array) -> Array:
        """Across corners, or close behind one: in parts, by the rule for singular ends; alike ones, between the same, together."""
        front = load - slipped
        first = np.searchsorted(self._break_loads, front, side="right")
        after = np.maximum(np.searchsorted(self._break_loads, load, side="left"), first)
        total = np.zeros(load.shape)
        pairs, alike = np.unique(np.stack([first, after]), axis=1, return_inverse=True)
        for number, (low, high) in enumerate(pairs.T):
            inside = self._break_loads[low:high]
            size = max(CHUNK // (len(ROOTS.up) * (len(inside) + 1)), 1)
            members = np.flatnonzero(alike.ravel() == number)
            for here in np.split(members, np.arange(size, len(members), size)):
                node = panels(0.0, slipped[here], [at - front[here] for at in inside])
                half = self.half_width(front[here, None, None] + node.at)
                rate = half * self.stiffness(half)
                terms = node.weight * node.below / np.where(rate > 0, rate, np.inf)
                total[here] = np.sum(terms, axis=(-2, -1))
        return total
