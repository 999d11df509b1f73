"""Integrals over a pile of flat punches as functions of a half-width, for many points at once: piecewise Chebyshev series.

# notation: a half-width, alpha that of a punch, g = dP/d alpha, b where a stretch without corners begins, x distance of a point

    pressure   (1/pi) int_x^a w g/sqrt(alpha^2 - x^2) d alpha      alpha = max(x, b) + |x - b| sinh^2 v
    spread     int_0^a W x/(alpha sqrt(x^2 - alpha^2)) d alpha     alpha = b + (x - b) sin^2 v
    logarithm  int_0^a W/alpha d alpha                             alpha = b + v^2

with w = 1 or P, W = P or P^2/2. Behind a corner g is a smooth function of sqrt(alpha - b) only, and so are the integrands in v: the
two roots are rationalised together. A series that is not resolved is halved; what its last coefficients are worth is the error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from scenes.chebyshev import NODES, clenshaw, series, tail

Array = NDArray[np.float64]
Kind = Literal["pressure", "spread", "logarithm"]
Law = Callable[[Array], Array]

_LONGEST = {"pressure": 1.2, "spread": 0.8, "logarithm": np.inf}
_CLOSEST = 1e-24
_RESOLVED = 4e-15
_HALVINGS = 12
_NOISE = 0.9
_CHUNK = 20_000

OCTAVES = 24
"""Halvings of the largest half-width down to which results have all their digits."""


@dataclass(frozen=True, eq=False)
class Panels:
    """Ranges [begin, end] of v: `point` (n,) whose they are, `low` the half-width at v = 0, `scale` = sqrt(|x - b|) or 1."""

    point: NDArray[np.intp]
    x: Array
    low: Array
    scale: Array
    begin: Array
    end: Array

    def take(self, which: NDArray[np.intp]) -> Panels:
        """Some of them."""
        return Panels(*(values[which] for values in vars(self).values()))


@dataclass(frozen=True, eq=False)
class Sheet:
    """One of the integrals at points `x` (k,), ascending, up to the half-width `top`.

    Attributes
    ----------
    panels, first : where each series holds; half-width at its lower end
    coefficients : (m, n) of the primitive over each panel
    error : (n,) what the series of a point left out up to the end of each panel may be worth
    """

    kind: Kind
    x: Array
    top: float
    panels: Panels
    first: Array
    coefficients: Array
    error: Array

    def __call__(self, point: NDArray[np.intp], half: Array) -> tuple[Array, Array]:
        """The integral up to `half` at the points of these numbers, arrays of one shape, and its error."""
        keys = self.panels.point + self.first / (2 * self.top)
        number = np.searchsorted(keys, point + half / (2 * self.top), side="right") - 1
        # Below its first panel a point has nothing yet.
        number = np.maximum(number, np.searchsorted(self.panels.point, point))
        panels = self.panels
        root = np.sqrt(np.maximum(half - panels.low[number], 0.0))
        if self.kind == "pressure":
            v = np.arcsinh(root / panels.scale[number])
        elif self.kind == "spread":
            v = np.arctan2(root, np.sqrt(np.maximum(self.x[point] - half, 0.0)))
        else:
            v = root
        begin, end = panels.begin[number], panels.end[number]
        t = np.clip((2 * v - begin - end) / (end - begin), -1.0, 1.0)
        return clenshaw(self.coefficients, number, t), self.error[number]


def sheet_of(kind: Kind, x: Array, top: float, begins: Array, laws: tuple[Law, Law], order: int) -> Sheet:
    """The integral of an order (0: w = 1, 1: w = P) at points `x` (k,), ascending.

    Parameters
    ----------
    top : largest half-width
    begins : b of the stretches in which the laws are smooth in sqrt(alpha - b): a(0) and the corners
    laws : P and dP/da
    """
    # Octaves, so that a small half-width has digits of its own.
    octaves = begins[0] + (top - begins[0]) * 0.5 ** np.arange(1, OCTAVES)
    marks = np.append(np.union1d(begins[begins < top], octaves), top)
    panels = _panels(kind, x, marks, begins)
    found, coefficients, tails = [], [], []
    coarse = np.full(len(panels.point), np.inf)
    for turn in range(_HALVINGS + 1):
        parts = _coefficients(kind, panels, laws, order)
        length = (panels.end - panels.begin) / 2
        rest = tail(parts)
        worth = rest * length
        # What halving does not make smaller is noise of the laws themselves: it stays, and counts as error.
        good = (worth <= _RESOLVED * _size(kind, panels, parts, laws, order)) | (rest > _NOISE * coarse) | (turn == _HALVINGS)
        found.append(panels.take(np.flatnonzero(good)))
        coefficients.append(parts[good])
        tails.append(worth[good])
        panels, coarse = _halves(panels.take(np.flatnonzero(~good))), np.tile(rest[~good], 2)
        if not len(panels.point):
            break
    whole = Panels(*(np.concatenate(part) for part in zip(*(vars(each).values() for each in found), strict=True)))
    order_of = np.lexsort((whole.begin, whole.low, whole.point))
    return _joined(kind, x, top, whole.take(order_of), np.concatenate(coefficients)[order_of], np.concatenate(tails)[order_of])


def _size(kind: Kind, panels: Panels, parts: Array, laws: tuple[Law, Law], order: int) -> Array:
    """What the last digit of each panel counts from, (n,): its own integral, or all up to its end where that is about W there."""
    own = np.abs(parts[:, 0]) * (panels.end - panels.begin) / 2
    if kind == "pressure":
        return own
    force = laws[0](panels.low + np.square(_root(kind, panels.end, panels.scale)))
    return np.maximum(own, force * force / 2 if order else force)


def _panels(kind: Kind, x: Array, marks: Array, begins: Array) -> Panels:
    """Ranges of v between marks, (k, marks - 1) of them less those that are empty, cut to the greatest length."""
    b = begins[np.clip(np.searchsorted(begins, marks[:-1], side="right") - 1, 0, None)]
    low, high, start = marks[:-1], marks[1:], b
    point = np.arange(len(x))[:, None]
    at = x[:, None]
    if kind == "pressure":
        origin = np.maximum(at, start)
        scale = np.sqrt(np.maximum(np.where(start > 0, np.abs(at - start), 2 * at), max(_CLOSEST * marks[-1], 1e-300)))
        first, last = np.maximum(low, origin), high + 0 * at
    elif kind == "spread":
        origin, scale = start + 0 * at, np.sqrt(np.maximum(at - start, 0.0))
        first, last = low + 0 * at, np.minimum(high, at)
    else:
        origin, scale = start + 0 * at, np.ones((len(x), len(start)))
        first, last = low + 0 * at, high + 0 * at
    here = np.nonzero(last > first)
    part = [np.broadcast_to(values, (len(x), len(start)))[here] for values in (point, at, origin, scale, first, last)]
    inner, outer = (_variable(kind, half, part[1], part[2], part[3]) for half in (part[4], part[5]))
    longest = _LONGEST[kind]
    count = np.maximum(np.ceil((outer - inner) / longest), 1).astype(int)
    which = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    step = ((outer - inner) / count)[which]
    begin = inner[which] + number * step
    end = np.where(number == count[which] - 1, outer[which], begin + step)
    return Panels(part[0][which], part[1][which], part[2][which], part[3][which], begin, end)


def _variable(kind: Kind, half: Array, x: Array, low: Array, scale: Array) -> Array:
    root = np.sqrt(np.maximum(half - low, 0.0))
    if kind == "pressure":
        return np.arcsinh(root / scale)
    return np.arctan2(root, np.sqrt(np.maximum(x - half, 0.0))) if kind == "spread" else root


def _halves(panels: Panels) -> Panels:
    middle = (panels.begin + panels.end) / 2
    lower, upper = ({**vars(panels), "end": middle}, {**vars(panels), "begin": middle})
    return Panels(*(np.concatenate([lower[name], upper[name]]) for name in lower))


def _coefficients(kind: Kind, panels: Panels, laws: tuple[Law, Law], order: int) -> Array:
    """Series of the integrands over v, (n, nodes)."""
    parts = [np.empty((0, len(NODES)))]
    for k in range(0, len(panels.point), _CHUNK):
        part = panels.take(np.arange(k, min(k + _CHUNK, len(panels.point))))
        v = part.begin[:, None] + (part.end - part.begin)[:, None] * (1 + NODES) / 2
        parts.append(series(_integrand(kind, v, part.x[:, None], part.low[:, None], part.scale[:, None], laws, order)))
    return np.concatenate(parts)


def _integrand(kind: Kind, v: Array, x: Array, low: Array, scale: Array, laws: tuple[Law, Law], order: int) -> Array:
    load, stiffness = laws
    if kind == "pressure":
        root = _root(kind, v, scale)
        half = low + root * root
        weight = stiffness(half) * (load(half) if order else 1.0)
        beyond = np.where(low > x, (low - x) + root * root, root * root)
        return weight * 2 * root * scale * np.cosh(v) / np.sqrt(beyond * (half + x)) / np.pi
    root = _root(kind, v, scale)
    half = low + root * root
    force = load(half)
    weight = np.where(half > 0, (force * force / 2 if order else force) / np.where(half > 0, half, 1.0), 0.0)
    return weight * 2 * root * (x / np.sqrt(x + half) if kind == "spread" else 1.0)


def _joined(kind: Kind, x: Array, top: float, panels: Panels, parts: Array, tails: Array) -> Sheet:
    """Primitives that go on from panel to panel of a point; a point without panels gets one that is 0."""
    missing = np.setdiff1d(np.arange(len(x)), panels.point)
    length = (panels.end - panels.begin) / 2
    primitive = chebyshev.chebint(parts.T, lbnd=-1) * length
    rise = np.sum(primitive, axis=0)
    # Point by point: one sum through all points would leave the rounding of the largest in the smallest.
    place = np.arange(len(rise)) - np.searchsorted(panels.point, panels.point)
    table = np.zeros((len(x), int(np.max(place, initial=0)) + 2))
    table[panels.point, place + 1] = rise
    primitive[0] += np.cumsum(table, axis=1)[panels.point, place]
    table[panels.point, place + 1] = tails
    error = np.cumsum(table, axis=1)[panels.point, place + 1]
    kept = np.flatnonzero(np.max(np.abs(primitive), axis=1, initial=0.0) > 1e-18 * np.max(np.abs(primitive), initial=1e-300))
    primitive = primitive[: kept[-1] + 1 if len(kept) else 1]
    if len(missing):
        zero = np.zeros(len(missing))
        empty = Panels(missing, x[missing], zero, zero + 1, zero, zero + 1)
        panels = Panels(*(np.concatenate(pair) for pair in zip(vars(panels).values(), vars(empty).values(), strict=True)))
        primitive = np.concatenate([primitive, np.zeros((len(primitive), len(missing)))], axis=1)
        order = np.lexsort((panels.begin, panels.low, panels.point))
        panels, primitive, error = panels.take(order), primitive[:, order], np.append(error, zero)[order]
    first = panels.low + np.square(_root(kind, panels.begin, panels.scale))
    return Sheet(kind, x, top, panels, first, primitive, error)


def _root(kind: Kind, v: Array, scale: Array) -> Array:
    """sqrt(alpha - b) of v."""
    if kind == "pressure":
        return scale * np.sinh(v)
    return scale * np.sin(v) if kind == "spread" else v
