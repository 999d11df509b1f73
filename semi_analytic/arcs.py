"""Integrals over an arc of the load path that was travelled in full stick: what a curved piece of the memory leaves in q, s and U.

# notation: P_x load at which a = |x|; K kernel, of P alone or of P and x; P_t load at the turning point of P next to an end of the
#           arc;
#           z^2 = |P - P_t|, e^2 = +-(P_x - P_t), negative where P_x is beyond the turning point

    int Q'(t) K(x, P(t)) dt from the begin of the arc to each of many instants, P growing all along

    shear   K = 1/(pi sqrt(a^2 - x^2))  while |x| is inside
    slip    K = arccosh(|x|/a)          while |x| is outside
    shift   K = ln(2 L/a)

The arc is cut into panels, at the corners of the profile too. On a panel that is far from P_x (in loads, measured by its own range)
the integrand is smooth: one Chebyshev series in time serves all instants, and its last coefficients are its error. Near P_x, whose
inverse root (shear) or root (slip) meets a mirror image at the turning point of P, the variable ln(z + sqrt(z^2 - e^2)) makes it
smooth, for e^2 < 0 too, and arcsin(z/e) where it is sqrt(e^2 - z^2): there Gauss' rule goes from instant to instant. So an edge of
contact anywhere, and an arc that begins next to the least load or ends next to the largest, cost no digits. Where P is close to 0,
for the length of a step, and beside corners, behind which a(P) goes as d^(3/2), the rule for singular ends takes its place.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from scenes import LoadSegment
from scenes.chebyshev import DEGREE, NODES, series, tail
from semi_analytic.legs import NORMAL_LOAD, change, rate, time_of
from semi_analytic.memory import Piece, front_time
from semi_analytic.profiles import Contact
from semi_analytic.quadrature import gauss, graded

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Kernel = Literal["shear", "slip", "shift"]

# Panels at first, halvings of one at most, and the share of the largest integral at which a series is resolved.
_PANELS, _HALVINGS, _RESOLVED = 32, 8, 1e-14
# Ranges of a panel's load that P_x must be away from it: there the series leaves 5^-25 at most.
_FAR = 2.0
# Longest range of the variable, and how many of Gauss' nodes it takes. Against twice as many nodes tractions keep 2e-14 of the
# largest, slips and shifts 7e-14 (2e-13 for |x|^20).
_SPANS = ((0.12, 6), (0.4, 10), (1.2, 16), (2.5, 24), (6.0, 40), (math.inf, 80))
# Pairs of an instant and a point that are held at a time, and nodes.
_PAIRS, _NODES = 1_000_000, 2_000_000
# Digits, as a power of e, that Gauss' rule shall keep beside a logarithm.
_DIGITS = 34.0
# Share of the root of an arc's load from either side of a turning point that one series serves.
_THROUGH = 0.1
# Steps of which the error is looked at.
_SAMPLE = 40


class Turn(NamedTuple):
    """A turning point of P at an end of the arc or beyond it: its time and load; `sign` +1 for a least P, -1 for a largest.

    `farthest` is the other end of the arc. dQ/dz is smooth through the turning point, where the last digits of the time spoil P':
    for |z| < `near` it is a Chebyshev series, `force`; where P does not turn `near` is 0.
    """

    time: float
    load: float
    sign: float
    farthest: float
    near: float
    force: Array


def arc_integrals(contact: Contact, kernel: Kernel, piece: Piece, last: Array, x: Array) -> tuple[Array, float]:
    """The integrals over a piece's arc up to the times `last` (n,) at |x| (k,): shape (n, k), and the largest error.

    Of a shift `x` plays no part: all columns are alike.
    """
    assert piece.arc is not None  # for the type checker: only called for arcs
    if kernel == "shift":
        value, error = _integrals(contact, kernel, piece, last, np.zeros(1))
        return np.broadcast_to(value, (len(last), len(x))), error
    order = np.argsort(x, kind="stable")
    parts = [
        _integrals(contact, kernel, piece, last, x[some])
        for some in np.split(order, np.arange(_PAIRS // (len(last) + 1) + 1, len(x), _PAIRS // (len(last) + 1) + 1))
    ]
    value = np.empty((len(last), len(x)))
    value[:, order] = np.concatenate([part for part, _ in parts], axis=1)
    return value, max(error for _, error in parts)


def _integrals(contact: Contact, kernel: Kernel, piece: Piece, last: Array, x: Array) -> tuple[Array, float]:
    leg, first = piece.anchor.leg, piece.arc[0]  # type: ignore[index]
    last = np.clip(last, first, piece.anchor.time)
    end, edge = float(np.max(last, initial=first)), contact.load(x)
    if end <= first:
        return np.zeros((len(last), len(x))), 0.0
    loads = contact.break_loads
    loads = loads[(loads > piece.bottom) & (loads < piece.anchor.normal)]
    corners = front_time(piece, loads) if len(loads) else loads
    turns = _turn(leg, first, piece.anchor.time), _turn(leg, piece.anchor.time, first)
    middle = float(front_time(piece, (piece.bottom + piece.anchor.normal) / 2))
    marks = np.unique(np.clip(np.concatenate([corners, [middle], np.linspace(first, end, _PANELS + 1)]), first, end))
    far = _FarPanels(contact, kernel, leg, x, edge, corners)
    far.follow(marks)
    value = far.up_to(last)
    # Steps from instant to instant, for the points that are near their panel.
    stops = np.unique(np.concatenate([far.marks, last]))
    low, high = stops[:-1], stops[1:]
    panel = np.searchsorted(far.marks, low, side="right") - 1
    step, point = np.nonzero(far.near[panel])
    cornered = far.cornered[panel]
    rises = np.zeros((len(stops), len(x)))
    error = 0.0
    for turn, part in zip(turns, (low[step] < middle, low[step] >= middle), strict=True):
        s, i = step[part], point[part]
        rises[s + 1, i] = _near(contact, kernel, leg, turn, low[s], high[s], x[i], edge[i], cornered[s])
        some = np.unique(np.linspace(0, len(s) - 1, _SAMPLE).astype(int)) if len(s) else np.empty(0, dtype=int)
        a, b, at, on, beside = low[s[some]], high[s[some]], x[i[some]], edge[i[some]], cornered[s[some]]
        halves = [_near(contact, kernel, leg, turn, *ends, at, on, beside) for ends in ((a, (a + b) / 2), ((a + b) / 2, b))]
        off = np.max(np.abs(rises[s[some] + 1, i[some]] - sum(halves)), initial=0.0)
        error += float(off) * math.sqrt(np.max(np.bincount(i), initial=0))
    value += np.cumsum(rises, axis=0)[np.searchsorted(stops, last)]
    factor = 1 / math.pi if kernel == "shear" else 1.0
    return factor * value, factor * (error + far.error)


def _turn(leg: LoadSegment, end: float, other: float) -> Turn:
    """The turning point of P at an end of an arc, or beyond it by less than its length; the end itself where there is none.

    `other` is the other end. The leg's formulas hold beyond its ends too.
    """
    length, time = other - end, end
    width, sign = 1e-3 * length, math.copysign(1.0, length)
    for _ in range(20):
        slope = float(rate(leg, NORMAL_LOAD, time))
        bend = float(rate(leg, NORMAL_LOAD, time + width) - rate(leg, NORMAL_LOAD, time - width)) / (2 * width)
        if bend * sign <= 0 or abs(step := slope / bend) > abs(length) or (end - time + step) * sign < -abs(width):
            return Turn(end, float(leg.loads(end)[0]), sign, other, 0.0, np.zeros(1))
        time -= step
        if abs(step) <= 1e-15 * (abs(time) + abs(length)):
            break
    time = min(time, end) if length > 0 else max(time, end)
    # At the turning point itself the last digits of the time do not count.
    turn = Turn(time, float(leg.loads(time)[0]), sign, other, 0.0, np.zeros(1))
    near = _THROUGH * math.sqrt(abs(float(change(leg, NORMAL_LOAD, other, time))))
    # An even number of nodes: at 0 itself dQ/dz is 0/0.
    place = chebyshev.chebpts1(14)
    z = near * np.abs(place)
    across = time - 2 * (float(time_of(leg, NORMAL_LOAD, sign * near**2, time, other)) - time)
    sides = _force_over_root(leg, turn, z), _force_over_root(leg, turn._replace(farthest=across), z)
    return turn._replace(
        near=near, force=np.asarray(chebyshev.chebfit(place, np.where(place > 0, *sides), len(place) - 1), dtype=float)
    )


def _force_over_root(leg: LoadSegment, turn: Turn, z: Array) -> Array:
    """|dQ/dz| with the sign of dQ/dt, from dP = 2 z dz."""
    time = time_of(leg, NORMAL_LOAD, turn.sign * z * z, turn.time, turn.farthest)
    slope = np.abs(rate(leg, NORMAL_LOAD, time))
    return np.asarray(leg.rates(time)[1] * 2 * z / np.where(slope > 0, slope, np.inf))


class _FarPanels:
    """Panels of an arc, and on those far from P_x the series of the integral in time.

    Attributes
    ----------
    marks : (m + 1,) ends of the panels
    near : (m, k) which points need steps of their own there
    cornered : (m,) panels beside corners
    error : what the series may have left out, for the worst point
    """

    def __init__(self, contact: Contact, kernel: Kernel, leg: LoadSegment, x: Array, edge: Array, corners: Array) -> None:
        self._contact, self._kernel, self._leg, self._x, self._edge, self._corners = contact, kernel, leg, x, edge, corners

    def follow(self, marks: Array) -> None:
        """Series on the panels between `marks`, halved until they are resolved."""
        done: list[tuple[NDArray[Any], ...]] = []
        low, high, size = marks[:-1], marks[1:], 0.0
        for turn in range(_HALVINGS + 1):
            near, cornered, panel, point, found = self._series(low, high)
            worth = tail(found)
            size = max(size, float(np.max(np.abs(found[:, 0]), initial=0.0)) * math.sqrt(len(low)))
            worst = np.zeros(len(low))
            np.maximum.at(worst, panel, worth)
            good = (worst <= _RESOLVED * size) | (turn == _HALVINGS)
            table = np.zeros((len(low), len(self._x), DEGREE + 1))
            table[panel, point] = found
            left = np.zeros((len(low), len(self._x)))
            left[panel, point] = worth
            done.append(tuple(values[good] for values in (low, high, near, cornered, table, left)))
            if np.all(good):
                break
            low, middle, high = low[~good], (low[~good] + high[~good]) / 2, high[~good]
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        low, high, near, cornered, table, left = (np.concatenate(parts) for parts in zip(*done, strict=True))
        order = np.argsort(low)
        self.marks = np.append(low[order], high[order[-1]])
        self.near, self.cornered = near[order], cornered[order]
        self._primitive = chebyshev.chebint(table[order], lbnd=-1, axis=2) / 2
        self.error = float(np.max(np.sum(left, axis=0), initial=0.0))

    def _series(self, low: Array, high: Array) -> tuple[NDArray[Any], ...]:
        """Near and rough panels; panel, point and coefficients (n, nodes) of the integrand over u for those that are far."""
        contact, x, edge, slip = self._contact, self._x, self._edge, self._kernel == "slip"
        begin, end = np.isin(low, self._corners), np.isin(high, self._corners)
        cornered = begin | end
        u = (1 + NODES) / 2
        share = np.where(cornered[:, None], u * u * (3 - 2 * u), u)
        time = low[:, None] + (high - low)[:, None] * share
        load = np.maximum(self._leg.loads(time)[0], 0.0)
        least, most = (np.maximum(self._leg.loads(ends)[0], 0.0)[:, None] for ends in (low, high))
        spread = _FAR * (most - least)
        empty = least < spread  # P is close to 0
        if slip:
            near, away = (edge > least) & ((edge < most + spread) | empty), (edge >= most + spread) & ~empty
        else:
            near, away = (edge < most) & (edge > least - spread), edge <= least - spread
        panel, point = np.nonzero(away)
        density = self._leg.rates(time)[1] * (high - low)[:, None] * np.where(cornered[:, None], 6 * u * (1 - u), 1.0)
        advance = contact.advance(load)
        found = np.empty((len(panel), DEGREE + 1))
        for k in range(0, len(panel), _NODES // (DEGREE + 1)):
            here = slice(k, k + _NODES // (DEGREE + 1))
            p, i = panel[here], point[here]
            values = _kernel(contact, self._kernel, x[i, None], load[p] - edge[i, None], load[p], advance[p])
            found[here] = series(density[p] * values)
        return near, cornered, panel, point, found

    def up_to(self, time: Array) -> Array:
        """The integrals over far panels up to each time (n,): shape (n, k)."""
        number = np.clip(np.searchsorted(self.marks, time, side="right") - 1, 0, len(self.marks) - 2)
        whole = np.sum(self._primitive, axis=2)
        before = np.concatenate([np.zeros((1, whole.shape[1])), np.cumsum(whole, axis=0)])[:-1]
        share = np.clip((time - self.marks[number]) / (self.marks[number + 1] - self.marks[number]), 0.0, 1.0)
        # The inverse of 3 u^2 - 2 u^3.
        u = np.where(self.cornered[number], 0.5 - np.sin(np.arcsin(1 - 2 * share) / 3), share)
        terms = chebyshev.chebvander(2 * u - 1, DEGREE + 1)
        value = before[number]
        for panel in np.unique(number):
            here = number == panel
            value[here] += terms[here] @ self._primitive[panel].T
        return value


def _kernel(contact: Contact, kernel: Kernel, x: Array, above: Array, load: Array, advance: Array) -> Array:
    """K from P - P_x, P and the advance of the edge."""
    if kernel == "shear":
        return contact.inverse_root(x, above, advance)
    return contact.arccosh_ratio(x, -above, advance) if kernel == "slip" else contact.log_ratio(load)


def _near(
    contact: Contact,
    kernel: Kernel,
    leg: LoadSegment,
    turn: Turn,
    low: Array,
    high: Array,
    x: Array,
    edge: Array,
    cornered: NDArray[np.bool_],
) -> Array:
    """The integrals from low[k] to high[k] at x[k], (m,): P_x is among the loads there or close to them, or P close to 0."""
    result = np.zeros(len(low))
    if not len(low):
        return result
    inner, outer = (np.sqrt(np.maximum(turn.sign * change(leg, NORMAL_LOAD, ends, turn.time), 0.0)) for ends in (low, high))
    inner, outer = np.minimum(inner, outer), np.maximum(inner, outer)
    square = turn.sign * (edge - turn.load)
    # An e of 0 would stretch the variable for ever.
    square = np.where(np.abs(square) < 1e-36 * outer**2, 1e-36 * outer**2, square)
    # The part on the side of P_x where the kernel is not 0: z^2 > e^2 or z^2 < e^2.
    beyond = (kernel != "slip") == (turn.sign > 0)
    a, b = _limits_beyond(inner, outer, square) if beyond else _limits_within(inner, outer, square)

    rough = cornered | (_beside_no_load(turn, a, b, square) if kernel == "slip" and not beyond else False)
    limit = -1.0
    for longest, count in (*_SPANS, (math.inf, 0)):
        here = np.flatnonzero((b > a) & (rough if not count else ~rough & (b - a > limit) & (b - a <= longest)))
        limit = longest
        for k in range(0, len(here), _NODES // (count or 193)):
            m = here[k : k + _NODES // (count or 193)]
            if count:
                node, weight = gauss(count)
                s, weight = a[m, None] + (b - a)[m, None] * node, (b - a)[m, None] * weight
            else:
                s, weight = graded(a[m], b[m])
            z, root = _nodes(s, square[m, None], beyond)
            load = np.maximum(turn.load + turn.sign * z * z, 0.0)
            force, close = _force_over_root(leg, turn, z), z < turn.near
            force[close] = chebyshev.chebval(z[close] / max(turn.near, 1e-300), turn.force)
            advance = contact.advance(load)
            above = root * root if kernel != "slip" else -root * root
            result[m] = np.sum(weight * root * force * _kernel(contact, kernel, x[m, None], above, load, advance), axis=1)
    return result


def _beside_no_load(turn: Turn, a: Array, b: Array, square: Array) -> NDArray[np.bool_]:
    """Which ranges of arcsin(z/e) are too close to where P = 0, +-i arsinh(sqrt(P_t)/e), for Gauss' rule with its count of nodes.

    n nodes leave rho^(-2 n), rho + 1/rho being twice the sum of the distances from a and b over b - a.
    """
    height = np.arcsinh(np.sqrt(max(turn.load, 0.0) / np.maximum(square, 1e-300)))
    limits, counts = (np.array(column, dtype=float) for column in zip(*_SPANS, strict=True))
    count = counts[np.searchsorted(limits, b - a)]
    return np.asarray(np.hypot(a, height) + np.hypot(b, height) < np.cosh(_DIGITS / (2 * count)) * (b - a))


def _limits_beyond(low: Array, high: Array, square: Array) -> tuple[Array, Array]:
    """ln(z + sqrt(z^2 - e^2)) over its value at z = |e| at both ends, arsinh(z/|e|) for e^2 < 0."""
    e = np.sqrt(np.abs(square))
    size = np.maximum(e, 1e-300)
    low, high = (np.where(square > 0, np.maximum(ends, e), ends) for ends in (low, high))
    # (z - e)(z + e), not z^2 - e^2: at z = e round-off would leave a root of 1e-8 in the latter.
    legs = (np.where(square > 0, np.sqrt(np.maximum((z - e) * (z + e), 0.0)), z) for z in (low, high))
    a, b = (np.arcsinh(leg / size) for leg in legs)
    return a, np.maximum(a, b)


def _limits_within(low: Array, high: Array, square: Array) -> tuple[Array, Array]:
    """arcsin(z/e) at both ends; equal where there is nothing within."""
    e = np.sqrt(np.maximum(square, 0.0))
    a, b = (np.arctan2(z, np.sqrt((e - z) * (e + z))) for z in (np.minimum(low, e), np.minimum(high, e)))
    return a, np.maximum(a, b)


def _nodes(s: Array, square: Array, beyond: bool) -> tuple[Array, Array]:
    """z and sqrt(|z^2 - e^2|) at s; dz = root ds."""
    e = np.sqrt(np.abs(square))
    if not beyond:
        return e * np.sin(s), e * np.cos(s)
    wide, narrow = e * np.cosh(s), e * np.sinh(s)
    return np.where(square > 0, wide, narrow), np.where(square > 0, narrow, wide)
