"""Stress next to the contact, from the tractions: a sine series in the angle across the contact,
Muskhelishvili's integral of it.

Elements cannot follow the roots that p and q have at the edges of contact and stick, so that nodal
stresses miss up to a third of the tension at the trailing edge. The tractions know it. With x = m -
h cos(theta) across the contact

    p = sum_k A_k sin(k theta),  q = sum_k B_k sin(k theta),   w = v - sqrt(v^2 - 1),  v = (m - z)/h, z = x + i y

their integral over a half-plane is A(z) = sum A_k w^k and B(z) = sum B_k w^k, on the face as inside
(y <= 0, the lower body):

    s_xx = Im A + 2 Re B + y (Re A' - Im B'),   s_yy = Im A - y (Re A' - Im B'),   s_xy = -Im B - y (Im A' + Re B')

It is a piece of half-plane theory inside the finite elements, as the far field is. What a body of
finite size adds is a field without tractions on a flat face: a power series sum_k c_k z^k of the
potential, fitted to what the elements have beyond that integral where they are good, a little below
the face and beside the contact.

Of the nodal p the outermost three on each side are the mesh's: the edge of contact is where p^2,
which grows in proportion to the distance from a smooth edge, extrapolates to 0 from the nodes
further in, and p comes from there. Jumps of the profile's curvature bend p^2 without end: p over
their form (`_form`) is what is fitted. What the mesh adds there alternates between corners and
mid-side nodes and dies out: a term of that form is fitted with the parabola of p^2, and left out.
Where it slips, q = +-f p.

Source: Muskhelishvili (1953), Some Basic Problems of the Mathematical Theory of Elasticity; Johnson
(1985), section 2.5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.fft import dst

from halfplane_fe.arrays import Array, Complex

# Outermost nodes of the contact that are the mesh's own. Share of the half-width behind them that
# p^2 is fitted to on fine meshes: there the error of single nodes is left, which many nodes make
# small. Nodes that it is fitted to: fewest of all, on a coarse mesh, and most.
_RIM, _SPAN, _FEWEST, _USUAL, _MANY_FITTED = 3, 0.17, 6, 16, 48
# Least uncertainty of the tension over f p0, by r, the spacing of the nodes over the half-width:
# what is left of the error of single ones on coarse meshes, in proportion to sqrt(r), and on fine
# ones, where many are fitted, in proportion to r.
_LEAST_COARSE, _LEAST_FINE = 0.06, 0.6
# Degree of p^2 behind the rim.
_DEGREE = 2
# Other rims, shares of the nodes behind them, and degrees, whose answers say how uncertain the
# tension
# is. A parabola lacks the higher powers that p^2 has above a flat bottom: half as many nodes, or
# one
# degree more, leave about half of what that makes, and as coarse meshes fit fewer nodes, so do
# other
# rims. The error of the tension may be so many times the largest difference: 1.6 to 2.5 on 22
# profiles.
_OTHER_RIMS = ((2, 0.7, _DEGREE), (4, 1.0, _DEGREE), (_RIM, 0.5, _DEGREE), (_RIM, 1.0, _DEGREE + 1))
_BY_OTHERS = 2.5
# Root mean square of the relative residual of p^2 above which fewer nodes are fitted: a corner of
# the profile is among them.
_ROUGH = 0.02
FEWEST = 3
"""Fewest nodes in contact whose tractions have a series."""
# Angles over nodes of the contact; at least and at most.
_ANGLES, _FEW, _MANY = 8, 512, 8192
# Size of w^k below which the series ends.
_NEGLIGIBLE = 1e-10
# Distance from an edge over the half-width at which what is finite there counts as that of the
# edge.
_AT_EDGE = 1e-9
# Terms of the power series of the rest.
_TERMS = 7


@dataclass(frozen=True, eq=False)
class Tractions:
    """p and q across one contact at one instant as sine series.

    Attributes
    ----------
    edges : x at the left and right edge of contact [length]
    pressure, shear : (k,) A_k and B_k from k = 1 on [stress]
    rough : whether there were too few nodes to find the edges from p^2
    placed : what q at the nodes lacked of the load and was put at the stick edges changes the
        tension by, at most [stress]
    """

    edges: tuple[float, float]
    pressure: Array
    shear: Array
    rough: bool
    placed: float = 0.0

    @property
    def middle(self) -> float:
        """m."""
        return sum(self.edges) / 2

    @property
    def half_width(self) -> float:
        """h."""
        return (self.edges[1] - self.edges[0]) / 2

    def edge_tension(self) -> Array:
        """s_xx of the lower body at its left and right edge, (2,) [stress]: 2 sum B_k and 2 sum
        (-1)^k B_k.
        """
        return np.array(
            [2 * self.shear.sum(), 2 * self.shear[1::2].sum() - 2 * self.shear[::2].sum()]
        )

    def moments(self) -> Array:
        """int p t^k dt and int q t^k dt for k = 0, 1, 2, from the origin, (6,)."""
        m, h, found = self.middle, self.half_width, []
        for series in (self.pressure, self.shear):
            total, first = math.pi / 2 * h * series[0], -math.pi / 4 * h**2 * series[1]
            second = math.pi / 8 * h**3 * (series[0] + series[2])
            found += [total, m * total + first, m**2 * total + 2 * m * first + second]
        return np.array(found)

    def stress(self, x: Array, y: Array) -> Array:
        """(n, 3) s_xx, s_yy, s_xy of the half-plane y <= 0 at (n,) places [stress]."""
        v = (self.middle - x + 0j) / self.half_width
        v.imag = np.abs(y) / self.half_width
        # From above the cut of the root, so that the face counts as inside the body; |w| <= 1.
        root = np.sqrt(v - 1) * np.sqrt(v + 1)
        w = v - root
        sums = _sums(np.stack([self.pressure, self.shear]), w)
        with np.errstate(divide="ignore", invalid="ignore"):
            # y A', y B'; dw/dz = w/(h root)
            slopes = np.where(y == 0, 0.0, y * sums[2:] / (self.half_width * root))
        bent, pressed = slopes[0].real - slopes[1].imag, sums[0].imag
        rows = (
            pressed + 2 * sums[1].real + bent,
            pressed - bent,
            -sums[1].imag - slopes[0].imag - slopes[1].real,
        )
        return np.stack(rows, axis=-1)


def _sums(series: Array, w: Complex) -> Complex:
    """sum A_k w^k, sum B_k w^k, sum k A_k w^k, sum k B_k w^k: (4, n) from (2, k), by Horner's rule
    from where w^k counts.
    """
    count, size = series.shape[1], np.abs(w)
    with np.errstate(divide="ignore"):
        needed = np.minimum(
            np.ceil(math.log(_NEGLIGIBLE) / np.log(np.minimum(size, 1 - 1e-12))), count
        ).astype(int)
    order = np.argsort(-needed, kind="stable")
    terms, at = np.maximum(needed[order], 1), w[order]
    weights = np.concatenate([series, np.arange(1, count + 1) * series])
    total = np.zeros((4, len(w)), dtype=complex)
    # how many points need term k
    active = np.searchsorted(-terms, -np.arange(1, count + 1), side="right")
    for k in range(int(terms.max(initial=0)), 0, -1):
        n = active[k - 1]
        total[:, :n] += weights[:, k - 1, None]
        total[:, :n] *= at[:n]
    found = np.empty_like(total)
    found[:, order] = total
    return found


@dataclass(frozen=True, eq=False)
class Nodal:
    """Nodal tractions of the nodes that touch at one instant, and what else is known there.

    Attributes
    ----------
    x, pressure, shear : (n,) [length], [stress]
    stick, contact : edges of stick (NaN in full slip) and contact, as the answer has them [length]
    friction : f
    tangential_load : sum of the nodal forces of q: what the smoothed q lacks of it is put at the
    stick edges growing : whether P grows by |dQ|/f at least: then a slip zone that no node shows is
    none
    kinks : (k, 2) x at which the curvature of the profile jumps, and E* times its jump from left to
        right [length, stress/length]
    """

    x: Array
    pressure: Array
    shear: Array
    stick: tuple[float, float]
    contact: tuple[float, float]
    friction: float
    tangential_load: float
    growing: bool
    kinks: Array = field(default_factory=lambda: np.empty((0, 2)))

    def slips(self, nodes: int) -> bool:
        """Whether slip zones at both edges, of so many nodes at least, enclose a stick zone."""
        return (
            math.isfinite(self.stick[0])
            and self.stick[0] > self.x[nodes - 1]
            and self.stick[1] < self.x[-nodes]
        )


Rim = tuple[int, float, int]


def tractions(nodal: Nodal, rim: Rim = (_RIM, 1.0, _DEGREE), level: bool = False) -> Tractions:
    """The series of nodal tractions.

    Parameters
    ----------
    rim : outermost nodes that are left out, share that is taken of the nodes that p^2 is fitted to,
    and degree of the polynomial level : whether q/p stays what it is at the outermost node from
    there on, in full stick and in full slip
    """
    x, form = nodal.x, _form(nodal)
    p = nodal.pressure / form(x)
    fits = [_edge(x, p, rim), _edge(-x[::-1], p[::-1], rim)]
    known = [fit for fit in fits if fit is not None]
    rough = len(known) < 2
    edges = nodal.contact if rough else (known[0][0], -known[1][0])
    middle, half = (edges[0] + edges[1]) / 2, (edges[1] - edges[0]) / 2
    count = int(np.clip(_ANGLES * len(x), _FEW, _MANY))
    theta = math.pi * (np.arange(count) + 0.5) / count
    at = middle - half * np.cos(theta)
    inner = slice(None) if rough else slice(rim[0], -rim[0])
    inside = np.abs(x[inner] - middle) < half
    angle = np.arccos((middle - x[inner][inside]) / half)
    smooth = np.interp(theta, angle, p[inner][inside] / np.sin(angle)) * np.sin(theta)
    for side, (_, start, polynomial) in zip((1.0, -1.0), () if rough else known, strict=False):
        outside = side * at < start
        smooth[outside] = np.sqrt(
            np.maximum(np.polyval(polynomial, side * at[outside] - start), 0.0)
        )
    smooth = smooth * form(at)
    sheared = _shear(at, smooth, nodal, 0 if rough else rim[0], level)
    weights = np.sin(theta) * half * math.pi / count
    lacking = _where_it_lacks(at, smooth, weights, nodal) * (
        nodal.tangential_load - float(weights @ sheared)
    )
    of_pressure, of_shear, of_lacking = (_series(values) for values in (smooth, sheared, lacking))
    placed = Tractions(edges, of_pressure, of_lacking, rough).edge_tension()
    return Tractions(edges, of_pressure, of_shear + of_lacking, rough, float(np.abs(placed).max()))


def with_uncertainty(nodal: Nodal) -> tuple[Tractions | None, Array]:
    """`tractions`, and how far the tension at either edge may be off, (2,) [stress]; None where
    fewer than three nodes touch.

    The largest of a multiple of what other rims, fewer nodes or a higher degree change, and of what
    q/p
    that stays as it is at the outermost node changes; and what was put at the stick edges. Where
    the
    load has turned but no node shows it yet, what slip as narrow as the rim would change: q by 2 f
    p
    with p = K sqrt(d), hence s_xx by
    (8/pi) f K sqrt(width).
    """
    if len(nodal.x) < FEWEST:
        return None, np.zeros(2)
    found = tractions(nodal)
    own, spacing = found.edge_tension(), float(np.median(np.diff(nodal.x)))
    share = spacing / found.half_width
    least = min(_LEAST_COARSE * math.sqrt(share), _LEAST_FINE * share)
    apart = np.full(2, least * nodal.friction * float(nodal.pressure.max()))
    for rim in _OTHER_RIMS:
        apart = np.maximum(apart, _BY_OTHERS * np.abs(tractions(nodal, rim).edge_tension() - own))
    apart = np.maximum(apart, np.abs(tractions(nodal, level=True).edge_tension() - own))
    if not (nodal.growing or nodal.slips(_RIM + 1)) and math.isfinite(nodal.stick[0]):
        # p at a depth d into the contact is sum k A_k sqrt(2 d/h) there: p^2/d at the nodes of the
        # rim.
        inward = np.array(
            [nodal.x[: _RIM + 1] - found.edges[0], found.edges[1] - nodal.x[::-1][: _RIM + 1]]
        )[:, -1]
        pressed = np.array([nodal.pressure[: _RIM + 1], nodal.pressure[::-1][: _RIM + 1]])[:, -1]
        apart = apart + 8 / math.pi * nodal.friction * pressed * (inward > 0)
    return found, apart + found.placed


def _series(values: Array) -> Array:
    """Sines of values at the middles of equal angles; the highest is counted once, not twice."""
    found = np.asarray(dst(values, type=2) / len(values))
    found[-1] /= 2
    return found


def _form(nodal: Nodal) -> Callable[[Array], Array]:
    """What of p no root and no polynomial has: that of jumps of the profile's curvature, up to a
    factor.

    With x between the edges l and r of contact, phi the angle whose cosine is (b - m)/h, and a jump
    k of h'' at b,

        p = E* k/(2 pi) [phi sqrt((x - l) (r - x)) + (x - b) ln |...|] + sqrt((x - l) (r - x)) times
        what is smooth:

    the slope of p is infinite at b. What is smooth is taken as constant; where that does not leave
    a pressure, the form is 1.

    Source: Muskhelishvili's integral of h' = k max(x - b, 0) over sqrt((x - l) (r - x)).
    """
    left, right = nodal.contact
    middle, half = (left + right) / 2, (right - left) / 2
    inside = nodal.kinks[np.abs(nodal.kinks[:, 0] - middle) < half]

    def kinked(x: Array) -> Array:
        """p over the root by the jumps."""
        u = ((x - middle) / half).clip(-1 + _AT_EDGE, 1 - _AT_EDGE)
        root, found = np.sqrt(1 - u**2), np.zeros_like(u)
        for place, jump in inside.tolist():
            # Of a jump on the left the mirror image: curvature that ends there.
            side, b = (
                (1.0, (place - middle) / half)
                if place > middle
                else (-1.0, (middle - place) / half)
            )
            t, other = side * u, math.sqrt(1 - b**2)
            away = np.where(t == b, 1.0, t - b)
            log = np.where(t == b, 0.0, np.log(np.abs((1 - b * t + root * other) / away)))
            found += side * jump / (2 * math.pi) * (math.acos(b) + (t - b) * log / root)
        return found

    inner = nodal.x[_RIM:-_RIM] if len(nodal.x) > 3 * _RIM else nodal.x
    root = np.sqrt(np.maximum((inner - left) * (right - inner), (_AT_EDGE * half) ** 2))
    rest = (
        float(np.mean(nodal.pressure[_RIM:-_RIM] / root - kinked(inner)))
        if len(inner) < len(nodal.x)
        else 0.0
    )
    if not len(inside) or not np.all(rest + kinked(nodal.x) > 0):
        return np.ones_like
    return lambda x: rest + kinked(x)


def _edge(x: Array, p: Array, rim: Rim) -> tuple[float, float, Array] | None:
    """(edge, x of the outermost node that counts, p^2 beyond it) at the left end; None where no
    smooth edge is seen.
    """
    skipped, share, degree = rim
    near = (
        int(np.searchsorted(x, x[min(skipped, len(x) - 1)] + _SPAN * (x[-1] - x[0]) / 2)) - skipped
    )
    most = min(round(share * np.clip(near, _USUAL, _MANY_FITTED)), len(x) // 2 - skipped)
    exponents = np.arange(degree, -1, -1)
    while most >= _FEWEST:
        chosen = slice(skipped, skipped + most)
        away, square, number = x[chosen] - x[skipped], p[chosen] ** 2, np.arange(most)
        powers = away[-1] ** exponents
        columns = [
            *((away[:, None] ** exponents / powers).T / square),
            (-1.0) ** number / (number + 4),
        ]
        solved = np.linalg.lstsq(np.stack(columns, axis=1) * square[-1], np.ones(most), rcond=None)[
            0
        ]
        fit = solved[: degree + 1] * square[-1] / powers
        rms = math.sqrt(float(np.mean((np.polyval(fit, away) / square - 1) ** 2)))
        roots = np.roots(fit)
        roots = roots[(np.abs(roots.imag) < 1e-12) & (roots.real < 0)].real
        if rms < _ROUGH and len(roots):
            return float(x[skipped] + roots.max()), float(x[skipped]), fit
        most //= 2
    return None


def _shear(at: Array, smooth: Array, nodal: Nodal, rim: int, level: bool) -> Array:
    """q at the angles: +-f p where it slips, elsewhere linear in the angle across the stick zone
    between the nodes.
    """
    x, q = nodal.x, nodal.shear
    if not nodal.slips(1):
        # q/p has no root at the edge, in full stick and in full slip: linear from node to node, and
        # on to the edge.
        ratio = q / nodal.pressure
        found = np.interp(at, x, ratio)
        for end, behind, side in () if level else ((0, 1, -1.0), (-1, -2, 1.0)):
            outside = side * (at - x[end]) > 0
            found[outside] += (
                (ratio[end] - ratio[behind]) / (x[end] - x[behind]) * (at[outside] - x[end])
            )
        return np.asarray(np.clip(found, -nodal.friction, nodal.friction) * smooth)
    low, high = nodal.stick
    left, right = np.sign(q[0]) * nodal.friction, np.sign(q[-1]) * nodal.friction
    found = np.where(at < low, left, right) * smooth
    inside, sticks = (at > low) & (at < high), (x > low) & (x < high)
    sticks[:rim] = sticks[-rim or len(x) :] = False

    def angle(places: Array) -> Array:
        return np.arccos(np.clip((low + high - 2 * places) / (high - low), -1, 1))

    ends = np.interp([low, high], at, smooth) * [left, right]
    known = (
        np.concatenate([[0.0], angle(x[sticks]), [math.pi]]),
        np.concatenate([ends[:1], q[sticks], ends[1:]]),
    )
    found[inside] = np.interp(angle(at[inside]), *known)
    return np.asarray(found)


def _where_it_lacks(at: Array, smooth: Array, weights: Array, nodal: Nodal) -> Array:
    """Where a missing force belongs, of unit resultant: within three nodes of the stick edges; as p
    where there are none.

    As a smooth hump: a step of q would stretch the face without limit.
    """
    (low, high), width = nodal.stick, 3 * float(np.median(np.diff(nodal.x)))
    if nodal.slips(1):
        share = np.clip(np.minimum(np.abs(at - low), np.abs(high - at)) / width, 0.0, 1.0)
        hump = np.sin(math.pi * share) ** 2 * ((at > low) & (at < high))
        if hump.any():
            return np.asarray(hump / (weights @ hump))
    return np.asarray(smooth / (weights @ smooth))


# ------------------------------------------------------------------- what the size of the body adds


@dataclass(frozen=True, eq=False)
class Rest:
    """What a body of finite size adds to the half-plane's stress: coefficients (k, cases) of
    `rest_basis`, and where it holds.

    Attributes
    ----------
    length : unit of z [length]
    coefficients : (k, cases) [stress]
    error : (cases,) standard error of s_xx at the edge of a contact [stress]
    """

    length: float
    coefficients: Array
    error: Array

    def stress(self, x: Array, y: Array) -> Array:
        """(n, 3, cases) s_xx, s_yy, s_xy [stress]."""
        return np.asarray(rest_basis(x + 1j * y, self.length) @ self.coefficients)


def rest_basis(z: Complex, length: float) -> Array:
    """(n, 3, k): stress by the terms of a potential sum c_j (z/length)^j that leaves the face free,
    real and imaginary parts.

    s_xx + s_yy = 4 Re f, s_yy - i s_xy = f(z) - f(conj z) + 2 i y conj f'(z); the imaginary c_0 is
    a rotation without stress.
    """
    u, columns = z / length, []
    for power in range(_TERMS):
        for factor in (1.0, 1j) if power else (1.0,):
            here, there = factor * u**power, factor * u.conj() ** power
            slope = factor * power * u ** max(power - 1, 0) / length
            corner = here - there + 2j * z.imag * slope.conj()
            columns.append(
                np.stack([4 * here.real - corner.real, corner.real, -corner.imag], axis=-1)
            )
    return np.stack(columns, axis=-1)


def fitted_rest(
    x: Array, y: Array, stress: Array, weights: Array, length: float, edge: float
) -> Rest:
    """The rest from what elements have beyond the half-plane's stress at their nodes.

    Parameters
    ----------
    x, y, weights : (n,) nodes, y <= 0 from the face, and the area that each stands for
    stress : (n, 3, cases)
    length : unit of z [length]; edge : half-width of the contact [length]
    """
    root = np.sqrt(weights / weights.mean())[:, None, None]
    matrix = (rest_basis(x + 1j * y, length) * root).reshape(3 * len(x), -1)
    wanted = (stress * root).reshape(3 * len(x), -1)
    found, _, rank, _ = np.linalg.lstsq(matrix, wanted, rcond=1e-10)
    left = np.sqrt(np.sum((wanted - matrix @ found) ** 2, axis=0) / max(len(matrix) - rank, 1))
    at = rest_basis(np.array([edge + 0j, -edge + 0j]), length)[:, 0]
    share = np.sqrt(np.max(np.einsum("ij,jk,ik->i", at, np.linalg.pinv(matrix.T @ matrix), at)))
    return Rest(length, found, left * share)
