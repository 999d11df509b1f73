"""Mesh-refinement study: order, kind, value extrapolated to size zero and its uncertainty. No mechanics.

# notation: h size of a solution, phi its value, phi_0 the value at size zero, p order: phi = phi_0 + alpha h^p

P. J. Roache, J. Fluids Eng. 116 (1994) 405, for solutions that lie on such a curve; L. Eca and M. Hoekstra, J. Comput. Phys. 262
(2014) 104, for four and more solutions that scatter about one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

Array = NDArray[np.float64]
_Kind = Literal["monotone", "oscillating", "diverging", "exact", "too few"]

_SAFE, _DOUBTFUL = 1.25, 3.0
# Orders outside are looked for only to be told apart: beyond 16 a ratio of 2 leaves no digits between the two finest solutions.
_ORDERS = (0.01, 16.0)


@dataclass(frozen=True)
class Refinement:
    """Values of one quantity from solutions of different size, everything else fixed."""

    sizes: tuple[float, ...]  # h > 0 of each solution, finest first, strictly growing
    values: tuple[float, ...]  # phi of each solution, finite
    formal_order: float = 2.0  # largest order that theory admits; plausible ones lie between a quarter of it and a twentieth above
    rounding: float = 0.0  # differences up to this are none

    def __post_init__(self) -> None:
        if len(self.sizes) != len(self.values) or not self.sizes:
            raise ValueError(f"{len(self.sizes)} sizes for {len(self.values)} values")
        if min(self.sizes) <= 0 or any(np.diff(self.sizes) <= 0):
            raise ValueError(f"sizes {self.sizes} are not positive and growing: the finest comes first")
        if not all(map(math.isfinite, self.values)):
            raise ValueError(f"values {self.values} are not finite")

    @property
    def spread(self) -> float:
        """Largest less least value."""
        return max(self.values) - min(self.values)

    def plausible(self, order: float | None) -> bool:
        """Whether theory admits an observed order."""
        return plausible(order, self.formal_order)


def plausible(order: float | None, formal: float) -> bool:
    """Whether theory admits an observed order, for the formal order 2 those from 0.5 to 2.1 (Eca and Hoekstra 2014)."""
    return order is not None and formal / 4 <= order <= 1.05 * formal


@dataclass(frozen=True)
class Extrapolation:
    """What a refinement study says."""

    order: float | None  # observed p; None where there is none
    kind: _Kind  # how the values go as h falls
    value: float | None  # phi_0; None for a single solution
    # |phi_0 - truth| and |finest phi - truth| should both be less, about 19 times of 20; None for a single solution
    uncertainty: float | None
    rule: str  # in words


def observed_order(sizes: tuple[float, ...], values: tuple[float, ...]) -> float | None:
    """p of the curve through three solutions; None where they are not monotone or drift apart as h falls.

    >>> round(observed_order((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178)), 6)
    1.78617
    """
    # notation: phi_3 - phi_2 over phi_2 - phi_1 is (h_3^p - h_2^p)/(h_2^p - h_1^p), which grows with p
    fine, coarse = values[1] - values[0], values[2] - values[1]
    if fine == 0 or coarse / fine <= 0:
        return None
    middle, large = math.log(sizes[1] / sizes[0]), math.log(sizes[2] / sizes[1])

    def excess(p: float) -> float:
        return p * middle + math.log(math.expm1(p * large) / math.expm1(p * middle)) - math.log(coarse / fine)

    low, high = _ORDERS
    if excess(low) >= 0 or excess(high) <= 0:
        return None
    return float(brentq(excess, low, high, xtol=1e-14))


def kind_of(refinement: Refinement) -> _Kind:
    """How the values go as h falls, all solutions considered.

    Same sense throughout: monotone where a curve with p > 0 fits best, diverging otherwise. Changing sense: oscillating where
    the last change is smaller than the largest before it, diverging otherwise.
    """
    if len(refinement.values) < 3:
        return "too few"
    if refinement.spread <= refinement.rounding:
        return "exact"
    changes = np.diff(refinement.values)
    if np.all(changes > 0) or np.all(changes < 0):
        return "diverging" if _order(refinement) is None else "monotone"
    return "oscillating" if abs(changes[0]) < np.abs(changes[1:]).max() else "diverging"


def extrapolate(refinement: Refinement) -> Extrapolation:
    """Order, kind, value at size zero and its uncertainty.

    Solutions of which every three neighbours are monotone, with plausible orders that agree to a quarter of the formal one, follow
    a curve: Roache, safety factor 1.25, the uncertainty by the lowest of these orders. Monotone otherwise: least squares, not less
    than the spread of the three finest. Oscillating or diverging: the finest value, give or take no less than the spread of all.
    These floors are ours: of noise about as large as the trend, the published rules on four solutions cover four truths of five
    only, with the floors 94 of 100 (tests/test_reports_budget.py).

    >>> found = extrapolate(Refinement((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178)))
    >>> found.kind, round(found.value, 6), round(found.uncertainty / 0.97050, 6)
    ('monotone', 0.9713, 0.001031)
    """
    kind, count, finest = kind_of(refinement), len(refinement.values), refinement.values[0]
    if count == 1:
        return Extrapolation(None, kind, None, None, "a single solution says nothing")
    if refinement.spread <= refinement.rounding:
        return Extrapolation(None, kind, finest, refinement.rounding, "all solutions agree to rounding")
    if count == 2:
        step = _step(refinement, refinement.formal_order)
        return Extrapolation(None, kind, finest + step, _DOUBTFUL * abs(step), "formal order taken for granted, safety factor 3")
    orders = [observed_order(refinement.sizes[i : i + 3], refinement.values[i : i + 3]) for i in range(count - 2)]
    found = [order for order in orders if order is not None and refinement.plausible(order)]
    if len(found) == len(orders) and max(found) - min(found) <= refinement.formal_order / 4:
        least = _SAFE * abs(_step(refinement, min(found)))
        return Extrapolation(found[0], kind, finest + _step(refinement, found[0]), least, "Roache, safety factor 1.25")
    if count == 3:
        return Extrapolation(orders[0], kind, finest, _DOUBTFUL * refinement.spread, "the finest, three times the spread")
    return _least_squares(refinement, kind)


def _step(refinement: Refinement, order: float) -> float:
    """phi_0 - phi_1 by Richardson's extrapolation from the two finest solutions."""
    one, two = refinement.values[:2]
    return (one - two) / math.expm1(order * math.log(refinement.sizes[1] / refinement.sizes[0]))


@dataclass(frozen=True)
class _Fit:
    """A curve through scattered solutions: value at size zero, fitted finest value, standard deviation, order where it was free."""

    limit: float
    finest: float
    deviation: float
    order: float | None = None


def _least_squares(refinement: Refinement, kind: _Kind) -> Extrapolation:
    """Eca and Hoekstra (2014), section 3, with the floors of `extrapolate`."""
    fit, words, order = _chosen(refinement)
    typical = refinement.spread / (len(refinement.values) - 1)
    away, step = abs(refinement.values[0] - fit.finest), abs(fit.limit - fit.finest)
    safety = _SAFE if refinement.plausible(order) else _DOUBTFUL
    uncertainty = safety * step + fit.deviation + away
    if fit.deviation >= typical:
        uncertainty = _DOUBTFUL * fit.deviation / typical * (step + fit.deviation + away)
    if kind == "monotone":
        near = max(refinement.values[:3]) - min(refinement.values[:3])
        return Extrapolation(order, kind, fit.limit, max(uncertainty, near), f"least squares, {words}")
    widest = max(uncertainty, refinement.spread)
    return Extrapolation(None, kind, refinement.values[0], widest, f"the finest; scatter about {words}")


def _chosen(refinement: Refinement) -> tuple[_Fit, str, float | None]:
    """The curve that is trusted, in words, and the order observed."""
    half, formal = refinement.formal_order / 2, refinement.formal_order
    free = min((_free(refinement, weights) for weights in _weights(refinement)), key=lambda fit: fit.deviation)
    if free.order is not None and refinement.formal_order / 4 <= free.order <= refinement.formal_order:
        return free, f"order {free.order:.2f}", free.order
    powers: tuple[tuple[float, ...], ...] = ((half,), (formal,))
    if free.order is None or free.order < formal / 4:
        powers += ((half, formal),)
    fits = [(_fit(refinement, p, weights), p) for p in powers for weights in _weights(refinement)]
    best, chosen = min(fits, key=lambda pair: pair[0].deviation)
    return best, f"order {' and '.join(f'{p:g}' for p in chosen)} taken for granted", free.order


def _weights(refinement: Refinement) -> Iterator[Array]:
    """Equal ones, and 1/h; both of mean 1."""
    h = np.array(refinement.sizes)
    yield np.ones_like(h)
    yield len(h) / h / np.sum(1 / h)


def _order(refinement: Refinement) -> float | None:
    """Order of the best curve; None where it has p <= 0."""
    if len(refinement.values) == 3:
        return observed_order(refinement.sizes, refinement.values)
    return min((_free(refinement, weights) for weights in _weights(refinement)), key=lambda fit: fit.deviation).order


def _free(refinement: Refinement, weights: Array) -> _Fit:
    """The best curve of any order; its order is None at the ends of the range, where there is none."""
    h, values = np.array(refinement.sizes) / refinement.sizes[-1], np.array(refinement.values)
    away = values - np.average(values, weights=weights)

    def residual(orders: Array) -> Array:
        columns = h ** np.atleast_1d(orders)[:, None]
        columns = columns - np.average(columns, axis=1, weights=weights)[:, None]
        # Size of what a column can't explain: weighted sum of squares less that along the column.
        along = (weights * columns) @ away / np.sum(weights * columns**2, axis=1)
        return np.asarray(np.sum(weights * (away - along[:, None] * columns) ** 2, axis=1))

    grid = np.geomspace(*_ORDERS, 97)
    best = int(np.argmin(residual(grid)))
    order = None
    if 0 < best < len(grid) - 1:
        inside = (float(grid[best - 1]), float(grid[best + 1]))
        order = float(minimize_scalar(lambda p: residual(p)[0], bounds=inside, method="bounded", options={"xatol": 1e-9}).x)
    return _fit(refinement, (order or float(grid[best]),), weights, order)


def _fit(refinement: Refinement, powers: tuple[float, ...], weights: Array, order: float | None = None) -> _Fit:
    """Weighted least squares of phi_0 + sum alpha_k h^p_k; an `order` that was found counts as a parameter of the fit."""
    h, values = np.array(refinement.sizes) / refinement.sizes[-1], np.array(refinement.values)
    columns = np.column_stack([np.ones_like(h), *(h**p for p in powers)])
    root = np.sqrt(weights)
    coefficients = np.linalg.lstsq(columns * root[:, None], values * root, rcond=None)[0]
    fitted = columns @ coefficients
    freedom = max(len(h) - len(coefficients) - (order is not None), 1)
    deviation = math.sqrt(float(np.sum(weights * (values - fitted) ** 2)) / freedom)
    return _Fit(float(coefficients[0]), float(fitted[0]), deviation, order)
