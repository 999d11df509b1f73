"""Integrals over an arc of an ellipse that was appended in full stick: smooth after one substitution, whatever is nearby.

# notation: theta = t - pi, counted from the least load; z = sin(theta/2) in the lower half (P < P0), y = cos(theta/2) in
#           the upper;
#           P_x load at which a = |x|, z_x and y_x the values there

P - P_x = 2 P1 (z^2 - z_x^2) = 2 P1 (y_x^2 - y^2). Q = Q0 + (Q1/P1) cos(phase) (P - P0) + Q1 sin(phase) sin t: the middle
term is a straight line in the memory; the last is integrated here, with dQ = -+ Q1 sin(phase) g(z) dz, g(z) = 2 (1 - 2
z^2)/sqrt(1 - z^2). Where the integrand holds sqrt(z^2 - e^2)^(-+1), the variable ln(z + sqrt(z^2 - e^2)) makes it smooth,
for e^2 < 0 too; where it holds sqrt(e^2 - z^2)^(-+1), arcsin(z/e). So an edge of contact anywhere, and a stick phase that
starts next to the least load or ends next to the largest, cost no digits. Slips hold the logarithm of the load besides:
steps that are close to where P would be 0, for their length, take the rule for singular ends. Corners of the profile cut the
arcs; behind one P(a) goes like d^(3/2) of the distance from it, and steps near it have their nodes at cubes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import EllipseLeg
from semi_analytic.contact import Contact, corner_loads
from semi_analytic.quadrature import gauss, graded

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Longest range of the variable, and how many of Gauss' nodes it takes; behind corners, at cubes. Against twice as many nodes
# tractions keep 2e-14 of the largest, slips and shifts 7e-14 (2e-13 for |x|^20).
_SPANS = ((0.12, 6), (0.4, 10), (1.2, 16), (2.5, 24), (6.0, 40), (math.inf, 80))
_CORNERED = ((0.12, 16), (0.8, 24), (2.5, 40), (math.inf, 80))
# Steps that arcs up to few instants are integrated in.
_STEPS = 16
# e^2 below which arcs are short beside |e|: at 3 a (P_x - P_max)/(2 P1) is -1e10 for |x|^20.
_FAR = -1.0
# Digits, as a power of e, that Gauss' rule shall keep beside a logarithm.
_DIGITS = 34.0


class Nodes(NamedTuple):
    """Quadrature nodes z, their weights for dz / root, and root = sqrt(|z^2 - e^2|); the last axis counts the nodes."""

    z: Array
    weight: Array
    root: Array


class Half(NamedTuple):
    """The part of arcs (n,) in one half: z in [low, high], P = extreme + curvature z^2, dQ = sign Q1 sin(phase) g dz.

    `cubed` says to which end nodes crowd: 1 lower, -1 upper z, where P is least; 0 for profiles without corners.
    """

    low: Array
    high: Array
    sign: float
    extreme: float
    curvature: float
    cubed: int = 0


def halves(leg: EllipseLeg, first: float, last: Array) -> list[Half]:
    """Lower and upper part of the arcs from `first` to `last` (n,), P growing all along."""
    turn = math.floor((first - math.pi) / (2 * math.pi) + 1e-9)
    begin = max(first - math.pi - 2 * math.pi * turn, 0.0)
    end = np.clip(last - math.pi - 2 * math.pi * turn, begin, math.pi)
    mean, amplitude = leg.mean[0], leg.amplitude[0]
    middle = math.pi / 2
    found = []
    if begin < middle:
        low = np.full(end.shape, math.sin(begin / 2))
        found.append(Half(low, np.sin(np.minimum(end, middle) / 2), -1.0, mean - amplitude, 2 * amplitude))
    if np.any(end > middle):
        high = np.full(end.shape, math.sin((math.pi - max(begin, middle)) / 2))
        found.append(Half(np.sin((math.pi - np.maximum(end, middle)) / 2), high, 1.0, mean + amplitude, -2 * amplitude))
    return found


def _limits_outside(low: Array, high: Array, edge: Array) -> tuple[Array, Array]:
    """ln(z + sqrt(z^2 - e^2)) at both ends; for e^2 far below 0 arsinh(z/|e|), which keeps its digits where z is small beside e."""
    floor = np.sqrt(np.maximum(edge, 0.0))
    inner, outer = np.maximum(low, floor), np.maximum(high, floor)
    beyond = np.maximum(-edge, 0.0)
    # (z - e)(z + e), not z^2 - e^2: at z = e rounding would leave a root of 1e-8 in the latter.
    a = np.log(np.maximum(inner + np.sqrt((inner - floor) * (inner + floor) + beyond), 1e-150))
    b = np.log(np.maximum(outer + np.sqrt((outer - floor) * (outer + floor) + beyond), 1e-150))
    far = np.flatnonzero(edge < _FAR)
    if len(far):
        size = np.sqrt(-edge[far])
        a[far], b[far] = np.arcsinh(low[far] / size), np.arcsinh(high[far] / size)
    return a, np.maximum(a, b)


def outside(low: Array, high: Array, edge: Array, cubed: int, beside: bool = False) -> Nodes:
    """Nodes for low < z < high with z^2 > e^2 = `edge`, which may be negative. `beside` a singularity: many nodes."""
    a, b = _limits_outside(low, high, edge)
    s, weight = graded(a, b) if beside else _rule(a, b, cubed)
    r = np.exp(s)
    other = edge[..., None] / r
    z, root = (r + other) / 2, (r - other) / 2
    far = np.flatnonzero(edge < _FAR)
    if len(far):
        size = np.sqrt(-edge[far, None])
        z[far], root[far] = size * np.sinh(s[far]), size * np.cosh(s[far])
    return Nodes(z, weight, root)


def _limits_inside(low: Array, high: Array, edge: Array) -> tuple[Array, Array]:
    """arcsin(z/e) at both ends."""
    e = np.sqrt(np.maximum(edge, 0.0))
    low, high = np.minimum(low, e), np.minimum(high, e)
    a = np.arctan2(low, np.sqrt((e - low) * (e + low)))
    b = np.arctan2(high, np.sqrt((e - high) * (e + high)))
    return a, np.maximum(a, b)


def inside(low: Array, high: Array, edge: Array, cubed: int, beside: bool = False) -> Nodes:
    """Nodes for low < z < high with z^2 < e^2 = `edge`; weights are 0 where there are none. `beside` a singularity: many nodes."""
    e = np.sqrt(np.maximum(edge, 0.0))
    a, b = _limits_inside(low, high, edge)
    s, weight = graded(a, b) if beside else _rule(a, b, cubed)
    return Nodes(e[..., None] * np.sin(s), weight, e[..., None] * np.cos(s))


def _rule(a: Array, b: Array, cubed: int) -> tuple[Array, Array]:
    widest = float(np.max(b - a, initial=0.0))
    count = next(number for limit, number in (_CORNERED if cubed else _SPANS) if widest <= limit)
    node, weight = gauss(count)
    length = (b - a)[..., None]
    if not cubed:
        return a[..., None] + length * node, length * weight
    start = (a if cubed > 0 else b)[..., None]
    return start + cubed * length * node**3, 3 * length * weight * node**2


def density(z: Array) -> Array:
    """g(z) = 2 (1 - 2 z^2)/sqrt(1 - z^2) for z^2 <= 1/2 (nodes beyond have no weight)."""
    square = np.minimum(z * z, 0.5)
    return 2 * (1 - 2 * square) / np.sqrt(1 - square)


def arc_shear(contact: Contact, leg: EllipseLeg, first: float, last: Array, x: Array) -> Array:
    """Traction of the sine part of arcs from `first` to `last` (n,) at |x| (k,): shape (n, k) [stress]."""
    total = np.zeros((len(last), len(x)))
    edge_load = contact.load(x)
    for half in halves(leg, first, last):
        steps, order = _steps(half, corner_loads(contact))
        rises = np.zeros((len(order), len(x)))
        for here, nodes in _touched(steps, edge_load, half.curvature > 0):
            point = here[1][:, None]
            excess = abs(half.curvature) * nodes.root**2
            quotient = contact.root_quotient(x[point], excess, edge_load[point] + excess)
            rises[here] = np.sum(nodes.weight * density(nodes.z) * quotient, axis=-1)
        total += half.sign / math.sqrt(abs(half.curvature)) * _summed(rises, order)[: len(last)]
    return total * leg.amplitude[1] * math.sin(leg.phase) / math.pi


def arc_slip(contact: Contact, leg: EllipseLeg, first: float, last: Array, x: Array) -> Array:
    """int dQ arccosh(|x|/a) of the sine part over the loads at which |x| is outside: shape (n, k) [force per thickness]."""
    total = np.zeros((len(last), len(x)))
    edge_load = contact.load(x)
    for half in halves(leg, first, last):
        steps, order = _steps(half, corner_loads(contact))
        rises = np.zeros((len(order), len(x)))
        for here, nodes in _touched(steps, edge_load, half.curvature < 0):
            excess = abs(half.curvature) * nodes.root**2
            reach = contact.reach(x[here[1]][:, None], excess, half.extreme + half.curvature * nodes.z**2)
            rises[here] = np.sum(nodes.weight * nodes.root * density(nodes.z) * reach, axis=-1)
        total += half.sign * _summed(rises, order)[: len(last)]
    return total * leg.amplitude[1] * math.sin(leg.phase)


def _steps(half: Half, corners: Array) -> tuple[Half, Indices]:
    """The arcs in order of their length, each less the one before: short pieces, which few nodes serve.

    Arcs that end at the loads of `corners`, or at steps between few instants, are put in between; their numbers in the order come
    after those of the others.
    """
    low, high, rising = half.low, half.high, half.curvature > 0
    cubed, z = 0, np.empty(0)
    if len(corners):
        z = np.sqrt(np.maximum((corners - half.extreme) / half.curvature, 0.0))
        z = z[(z > np.min(low)) & (z < np.max(high))]
        cubed = 1 if rising else -1
    elif len(low) < _STEPS:
        # P(a) may bend sharply anywhere, a polynomial's that hardly grows: one long step would not see it.
        z = np.linspace(np.min(low), np.max(high), _STEPS + 1)[1:-1]
    if len(z):
        same = np.ones(len(z))
        low, high = np.append(low, same * low[0] if rising else z), np.append(high, z if rising else same * high[0])
    order = np.argsort(high - low, kind="stable")
    low, high = low[order], high[order]
    if rising:
        return half._replace(low=np.append(low[:1], high[:-1]), high=high, cubed=cubed), order
    return half._replace(low=low, high=np.append(high[:1], low[:-1]), cubed=cubed), order


def _summed(rises: Array, order: Indices) -> Array:
    """Whole arcs from their steps, each back in its place."""
    whole = np.empty(rises.shape)
    whole[order] = np.cumsum(rises, axis=0)
    return whole


def _touched(half: Half, edge_load: Array, beyond: bool) -> Iterator[tuple[tuple[Indices, Indices], Nodes]]:
    """Arcs and points (m,) that have a part of this half on the right side of P_x, and nodes there (m, nodes), by their count.

    `beyond` the edge z^2 = e^2 for tractions in the lower half and slips in the upper one, before it otherwise.
    """
    edge = (edge_load - half.extreme) / half.curvature
    e = np.sqrt(np.maximum(edge, 0.0))
    low, high = half.low[:, None], half.high[:, None]
    span = high - np.maximum(low, e) if beyond else np.minimum(high, e) - low
    instant, point = np.nonzero(span > 0)
    choose, limits = (outside, _limits_outside) if beyond else (inside, _limits_inside)
    a, b = limits(half.low[instant], half.high[instant], edge[point])
    spans, below = _CORNERED if half.cubed else _SPANS, -1.0
    beside = np.zeros(len(a), dtype=bool)
    if beyond == (half.curvature < 0):  # a slip
        beside = _beside_no_load(half, a, b, edge[point], spans)
        i, k = instant[beside], point[beside]
        if len(i):
            yield (i, k), choose(half.low[i], half.high[i], edge[k], half.cubed, beside=True)
    for limit, _ in spans:
        some = np.flatnonzero((b - a > below) & (b - a <= limit) & ~beside)
        below = limit
        if len(some):
            i, k = instant[some], point[some]
            yield (i, k), choose(half.low[i], half.high[i], edge[k], half.cubed)


def _beside_no_load(half: Half, a: Array, b: Array, edge: Array, spans: tuple[tuple[float, int], ...]) -> NDArray[np.bool_]:
    """Which ranges of a slip's variable from a to b (m,) are too close to where P = 0 for Gauss' rule with its count of nodes.

    P = 0 at z^2 = -P_min/(2 P1), that is arcsin(z/e) = +-i arsinh(sqrt(P_min/(2 P1))/e), and y^2 = P_max/(2 P1). n nodes leave
    rho^(-2 n), rho + 1/rho being twice the sum of the distances from a and b over b - a.
    """
    square = -half.extreme / half.curvature
    if half.curvature > 0:
        centre, height = np.zeros(len(a)), np.arcsinh(np.sqrt(max(-square, 0.0) / edge))
    else:
        end = np.full(len(a), math.sqrt(square))
        centre, height = _limits_outside(end, end, edge)[0], np.zeros(len(a))
    limits, counts = (np.array(column, dtype=float) for column in zip(*spans, strict=True))
    count = counts[np.searchsorted(limits, b - a)]
    distances = np.hypot(a - centre, height) + np.hypot(b - centre, height)
    return np.asarray(distances < np.cosh(_DIGITS / (2 * count)) * (b - a))


def arc_log(contact: Contact, leg: EllipseLeg, first: float, last: Array) -> Array:
    """int dQ ln(2 L/a) of the sine part: shape (n,) [force per thickness]."""
    total = np.zeros(len(last))
    for half in halves(leg, first, last):
        steps, order = _steps(half, corner_loads(contact))
        # The logarithm is singular at P = 0, next to the least load perhaps: z^2 = -P_min/(2 P1).
        edge = np.full(len(order), -half.extreme / half.curvature if half.curvature > 0 else -1.0)
        nodes = outside(steps.low, steps.high, edge, steps.cubed)
        ratio = contact.log_ratio(half.extreme + half.curvature * nodes.z**2)
        rises = np.sum(nodes.weight * nodes.root * density(nodes.z) * ratio, axis=-1)
        total += half.sign * _summed(rises, order)[: len(last)]
    return total * leg.amplitude[1] * math.sin(leg.phase)
