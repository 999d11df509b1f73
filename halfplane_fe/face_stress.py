"""Stress next to the contact, from the tractions: a sine series in the angle across the contact,
Muskhelishvili's integral of it.

Elements cannot follow the roots that p and q have at the edges of contact and stick. So nodal
stresses miss up to a third of the tension at the trailing edge. The tractions have it. With
x = m - h cos(theta) across the contact

    p = sum_k A_k sin(k theta),   q = sum_k B_k sin(k theta),
    w = v - sqrt(v^2 - 1),        v = (m - z)/h,   z = x + i y

their integral over a half-plane is A(z) = sum A_k w^k and B(z) = sum B_k w^k, on the face as inside
(y <= 0, the lower body):

    s_xx = Im A + 2 Re B + y (Re A' - Im B')
    s_yy = Im A - y (Re A' - Im B')
    s_xy = -Im B - y (Im A' + Re B')

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
from typing import NamedTuple

import numpy as np

from scenes.array_types import Array, Complex

# Outermost nodes of the contact that are the mesh's own.
RIM = 3
# Share of the half-width behind them that p^2 is fitted to on fine meshes: there the error of
# single nodes is left, which many nodes make small.
_SPAN = 0.3
# Of the width of the contact: places that differ by less are one.
_ROUND_OFF = 1e-9
# Nodes that p^2 is fitted to: fewest of all, on a coarse mesh, and most.
_FEWEST = 6
_USUAL = 16
_MANY_FITTED = 100
# Least uncertainty of the tension over f p0, by r, the spacing of the nodes over the half-width:
# what is left of the error of single ones on coarse meshes, in proportion to sqrt(r), and on fine
# ones, where many are fitted, in proportion to r.
_LEAST_COARSE = 0.022
_LEAST_FINE = 0.066
# Degree of p^2 behind the rim, by the fewest nodes that are fitted with it. On 11 profiles and
# elements of a/160 the tension has an error of 1e-3 at most with the fourth degree; x^5.3 has 2e-2
# with a parabola. Where fewer nodes are fitted, higher degrees follow the error of single ones.
_DEGREES = ((24, 4), (0, 2))
# Root mean square of the relative residual of p^2 above which fewer nodes are fitted: a corner of
# the profile is among them.
_ROUGH = 0.02
FEWEST = 3
"""Fewest nodes in contact whose tractions have a series."""
# Angles over nodes of the contact; at least and at most.
_ANGLES_PER_NODE = 8
_FEWEST_ANGLES = 512
_MOST_ANGLES = 8192
# Size of w^k below which the series ends.
_NEGLIGIBLE = 1e-10
# Distance from an edge over the half-width at which what is finite there counts as that of the
# edge.
_AT_EDGE = 1e-9
# Terms of the power series of what the size of a body adds.
_TERMS = 7


class RootFit(NamedTuple):
    """How p^2 is fitted behind an edge of contact.

    Attributes
    ----------
    rim
        outermost nodes that are left out
    share
        of the nodes that p^2 is fitted to on this mesh
    further_degrees
        of the polynomial, beyond that of so many nodes
    most_rough
        root mean square of the relative residual above which half as many nodes are fitted
    """

    rim: int = RIM
    share: float = 1.0
    further_degrees: int = 0
    most_rough: float = _ROUGH


_USUAL_FIT = RootFit()
# Other fits, whose answers show how uncertain the tension is. The polynomial lacks the higher
# powers that p^2 has above a flat bottom: half as many nodes, or one degree more, leave less of
# what that makes. As coarse meshes fit fewer nodes, so do other rims.
_OTHER_FITS = (
    RootFit(rim=2, share=0.7),
    RootFit(rim=4),
    RootFit(share=0.5),
    RootFit(further_degrees=1),
)
# Where p^2 is so rough that fewer nodes were fitted, what all of them give: its error is the larger
# one.
_UNSHORTENED_FIT = RootFit(most_rough=math.inf)
# The error of the tension over the largest difference of these: on random scenes below 1.1 in 97 of
# 100, of seeds 201 and 204 of benchmarks/covered.py values, both presets.
_BY_OTHERS = 1.4
# The same of a tabulated profile, whose curvature bends at every point of the table.
_BY_OTHERS_OF_TABLE = 2.8
# Share of what slip as narrow as the rim could change that it does change.
_UNSEEN = 0.7
# Share of the tension, times the nodes in contact, where these are too few to find the edges.
_BY_FEW_NODES = 2.0
# Share of the tension, times (spacing of the nodes over the half-width)^(3/2), that the meshes of
# coupled bodies leave: their part of the coupling of p and q bends q at the edges. On coarse meshes
# of blocks and pads, seed 240 of benchmarks/covered.py bodies, 3e-3 to 5e-3 of the tension; on a
# block of four half-widths 1e-3 at a/64, 5e-4 at a/91.
_BY_COUPLING = 2.0


@dataclass(frozen=True, eq=False)
class Tractions:
    """p and q across one contact at one instant as sine series.

    Attributes
    ----------
    edges
        x at the left and right edge of contact [length]
    pressure, shear
        (k,) A_k and B_k from k = 1 on [stress]
    rough
        whether there were too few nodes to find the edges from p^2
    placed
        what q at the nodes lacked of the load and was put at the stick edges changes the
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
        """Moments int p t^k dt and int q t^k dt for k = 0, 1, 2 over the contact, t from the
        origin, (6,).

        By the first three coefficients of the sine series of p and q, about the middle m, moved to
        the origin.
        """
        middle = self.middle
        half_width = self.half_width
        moments_of_both: list[float] = []
        for series in (self.pressure, self.shear):
            # about the middle
            total = math.pi / 2 * half_width * series[0]
            first_moment = -math.pi / 4 * half_width**2 * series[1]
            second_moment = math.pi / 8 * half_width**3 * (series[0] + series[2])
            moments_of_both += [
                total,
                middle * total + first_moment,
                middle**2 * total + 2 * middle * first_moment + second_moment,
            ]
        return np.array(moments_of_both)

    def stress(self, x: Array, y: Array) -> Array:
        """(n, 3) s_xx, s_yy, s_xy [stress] of the half-plane y <= 0 at (n,) places x, y under these
        p and q.

        By complex potentials A of the pressure and B of the shear, series in w = v - sqrt(v^2 - 1)
        with v = (m - x + i |y|)/h, m the middle and h the half-width of the contact.
        """
        v = (self.middle - x + 0j) / self.half_width
        v.imag = np.abs(y) / self.half_width
        # From above the cut of the root, so that the face counts as inside the body; |w| <= 1.
        root = np.sqrt(v - 1) * np.sqrt(v + 1)
        w = v - root
        A, B, *slope_sums = _sums(np.stack([self.pressure, self.shear]), w)
        with np.errstate(divide="ignore", invalid="ignore"):
            # y A', y B'; dw/dz = w/(h root)
            slope_A, slope_B = np.where(
                y == 0, 0.0, y * np.array(slope_sums) / (self.half_width * root)
            )
        with_depth = slope_A.real - slope_B.imag
        s_xx = A.imag + 2 * B.real + with_depth
        s_yy = A.imag - with_depth
        s_xy = -B.imag - slope_A.imag - slope_B.real
        return np.stack([s_xx, s_yy, s_xy], axis=-1)


def _sums(series: Array, w: Complex) -> Complex:
    """The sums of A_k w^k, B_k w^k, k A_k w^k and k B_k w^k over k = 1, 2, ... at points w (n,),
    |w| <= 1: (4, n) from `series` (2, k) of A_k and B_k.

    By Horner's rule from the last term that counts at a point. Points are sorted by their number of
    terms, longest first, so that those which have term k are the first ones.
    """
    series_length = series.shape[1]
    number = np.arange(1, series_length + 1)
    with np.errstate(divide="ignore"):
        terms_to_negligible = math.log(_NEGLIGIBLE) / np.log(np.minimum(np.abs(w), 1 - 1e-12))
        terms_needed = np.minimum(np.ceil(terms_to_negligible), series_length).astype(int)
    longest_first = np.argsort(-terms_needed, kind="stable")
    terms_needed = np.maximum(terms_needed[longest_first], 1)
    w_longest_first = w[longest_first]
    weights = np.concatenate([series, number * series])
    partial_sums = np.zeros((4, len(w)), dtype=complex)
    points_with_term = np.searchsorted(-terms_needed, -number, side="right")
    for k in range(int(terms_needed.max(initial=0)), 0, -1):
        n_points = points_with_term[k - 1]
        partial_sums[:, :n_points] += weights[:, k - 1, None]
        partial_sums[:, :n_points] *= w_longest_first[:n_points]
    sums = np.empty_like(partial_sums)
    sums[:, longest_first] = partial_sums
    return sums


@dataclass(frozen=True, eq=False)
class Nodal:
    """Nodal tractions of the nodes that touch at one instant, and what else is known there.

    Attributes
    ----------
    x, pressure, shear
        (n,) [length], [stress]
    stick, contact
        edges of stick (NaN in full slip) and contact, as the answer has them [length]
    friction
        f
    tangential_load
        sum of the nodal forces of q: what the smoothed q lacks of it is put at the stick edges
        [force per thickness]
    growing
        whether P grows by |dQ|/f at least: then a slip zone that no node shows is none
    kinks
        (k, 2) x at which the curvature of the profile jumps, and E* times its jump from left to
        right [length, stress/length]
    tabulated
        whether the profile is a curve through points
    coupled
        whether p and q act on each other: bodies of two shapes or materials
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
    tabulated: bool = False
    coupled: bool = False

    def slips(self, nodes: int) -> bool:
        """Whether slip zones at both edges, of so many nodes at least, enclose a stick zone."""
        return (
            len(self.x) > nodes
            and math.isfinite(self.stick[0])
            and self.stick[0] > self.x[nodes - 1]
            and self.stick[1] < self.x[-nodes]
        )


@dataclass(frozen=True, eq=False)
class SampledTractions:
    """p and q of one instant at angles across the contact: enough for the tension at its edges.

    Attributes
    ----------
    edges
        x at the left and right edge of contact [length]
    theta
        (n,) middles of n equal angles from the left edge to the right one
    pressure, shear
        (n,) p and q [stress]
    missing_shear
        (n,) what q at the nodes lacks of the load, put at the stick edges [stress]
    rough
        whether there were too few nodes to find the edges from p^2
    """

    edges: tuple[float, float]
    theta: Array
    pressure: Array
    shear: Array
    missing_shear: Array
    rough: bool

    def edge_tension(self) -> Array:
        """s_xx of the lower body at its left and right edge, (2,) [stress]."""
        return self._tension(self.shear) + self._tension(self.missing_shear)

    def placed(self) -> float:
        """What the missing shear changes the tension by, at most [stress]."""
        return float(np.abs(self._tension(self.missing_shear)).max())

    def _tension(self, shear: Array) -> Array:
        """2 sum B_k and 2 sum (-1)^k B_k of the series of `shear` as one weighted sum over angles.

        With B_k = (2/n) sum_j q_j sin(k theta_j), the highest once, and cos(n theta_j) = 0,

            2 sum_k B_k = (2/n) sum_j q_j cot(theta_j/2),
            2 sum_k (-1)^k B_k = -(2/n) sum_j q_j tan(theta_j/2)
        """
        tangent = np.tan(self.theta / 2)
        return 2 / len(shear) * np.array([np.sum(shear / tangent), -np.sum(shear * tangent)])

    def series(self) -> Tractions:
        """Both as sine series."""
        return Tractions(
            self.edges,
            pressure=_series(self.pressure),
            shear=_series(self.shear) + _series(self.missing_shear),
            rough=self.rough,
            placed=self.placed(),
        )


def tractions(nodal: Nodal, fit: RootFit = _USUAL_FIT, level: bool = False) -> Tractions:
    """The series of nodal tractions; parameters as `sampled_tractions`."""
    return sampled_tractions(nodal, fit, level).series()


def sampled_tractions(
    nodal: Nodal, fit: RootFit = _USUAL_FIT, level: bool = False
) -> SampledTractions:
    """Smoothed p and q at equal angles across the contact, by the nodal tractions and the edges of
    contact that a fit of p^2 finds; those of `nodal.contact` where there are too few nodes.

    Parameters
    ----------
    fit
        how p^2 is fitted behind the edges
    level
        whether q/p stays what it is at the outermost node from there to the edge, instead of
        following its slope, in full stick and in full slip
    """
    x = nodal.x
    form = _form(nodal)
    p_over_form = nodal.pressure / form(x)
    fit_at_left = _fitted_edge(x, p_over_form, fit)
    fit_at_right = _fitted_edge(-x[::-1], p_over_form[::-1], fit)  # mirrored
    rough = fit_at_left is None or fit_at_right is None
    edges = (
        nodal.contact
        if fit_at_left is None or fit_at_right is None
        else (fit_at_left.edge, -fit_at_right.edge)
    )
    middle = (edges[0] + edges[1]) / 2
    half_width = (edges[1] - edges[0]) / 2
    n_angles = _ANGLES_PER_NODE * len(x)
    n_angles = int(np.clip(n_angles, _FEWEST_ANGLES, _MOST_ANGLES))
    theta = math.pi * (np.arange(n_angles) + 0.5) / n_angles
    places = middle - half_width * np.cos(theta)
    behind_rims = slice(None) if rough else slice(fit.rim, -fit.rim)
    inner_x = x[behind_rims]
    inner_p = p_over_form[behind_rims]
    is_in_contact = np.abs(inner_x - middle) < half_width
    angle = np.arccos((middle - inner_x[is_in_contact]) / half_width)
    smooth_pressure = np.interp(theta, angle, inner_p[is_in_contact] / np.sin(angle)) * np.sin(
        theta
    )
    if fit_at_left is not None and fit_at_right is not None:
        for side, fit_at_edge in ((1.0, fit_at_left), (-1.0, fit_at_right)):
            is_beyond_start = side * places < fit_at_edge.start
            squared_p = np.polyval(
                fit_at_edge.square, side * places[is_beyond_start] - fit_at_edge.start
            )
            smooth_pressure[is_beyond_start] = np.sqrt(np.maximum(squared_p, 0.0))
    smooth_pressure = smooth_pressure * form(places)
    shear = _shear(places, smooth_pressure, nodal, 0 if rough else fit.rim, level)
    lengths = np.sin(theta) * half_width * math.pi / n_angles
    missing_load = nodal.tangential_load - float(lengths @ shear)
    missing_shear = _unit_missing_shear(places, smooth_pressure, lengths, nodal) * missing_load
    return SampledTractions(edges, theta, smooth_pressure, shear, missing_shear, rough)


def tension_of_nodes(nodal: Nodal) -> float:
    """The larger |s_xx| of the lower body at an edge of contact, by the shear at the nodes and the
    edges that the solution states: quick, to a tenth of itself [stress].

    (2/pi) int q cot(theta/2) d theta at the left edge, and with tan(theta/2) at the right one, what
    is integrated being constant between an edge and its outermost node.
    """
    left, right = nodal.contact
    middle = (left + right) / 2
    half_width = (right - left) / 2
    is_inside = np.abs(nodal.x - middle) < half_width
    angles = np.arccos((middle - nodal.x[is_inside]) / half_width)
    shear = nodal.shear[is_inside]
    if not len(shear):
        return 0.0
    tangent = np.tan(angles / 2)
    tensions = []
    for weighted_shear in (shear / tangent, shear * tangent):
        between_nodes = np.trapezoid(weighted_shear, angles)
        to_edges = weighted_shear[0] * angles[0] + weighted_shear[-1] * (math.pi - angles[-1])
        tensions.append(2 / math.pi * abs(float(between_nodes + to_edges)))
    return max(tensions)


class TractionsAndUncertainty(NamedTuple):
    """The series of an instant, and how uncertain its tension is at either edge.

    Attributes
    ----------
    series
        None where fewer than three nodes touch
    tension_uncertainty
        (2,) of the tension that the nodes show [stress]
    of_unseen_slip
        (2,) change of the tension by slip as narrow as the rim, which no node shows yet after a
        load has turned [stress]
    """

    series: Tractions | None
    tension_uncertainty: Array
    of_unseen_slip: Array


def tractions_with_uncertainty(nodal: Nodal) -> TractionsAndUncertainty:
    """Sine series of p and q across the contact, and the uncertainty of the tension s_xx at both
    its edges.

    The uncertainty is the largest of what three changes make, what was put at the stick edges, and
    what the meshes of coupled bodies leave. The changes: a multiple of what other rims, fewer nodes
    or a higher degree change; all nodes, where fewer were fitted because p^2 is rough; q/p that
    stays as it is at the outermost node. Beside it stands, where the load has turned but no node
    shows it yet, what slip as narrow as the rim changes: it changes q by 2 f p with p = K sqrt(d),
    hence s_xx by (8/pi) f K sqrt(width).
    """
    if len(nodal.x) < FEWEST:
        return TractionsAndUncertainty(None, np.zeros(2), np.zeros(2))
    series = tractions(nodal)
    tension = series.edge_tension()
    spacing = float(np.median(np.diff(nodal.x)))
    spacing_ratio = spacing / series.half_width
    least_uncertainty_ratio = min(
        _LEAST_COARSE * math.sqrt(spacing_ratio), _LEAST_FINE * spacing_ratio
    )
    uncertainty = np.full(2, least_uncertainty_ratio * nodal.friction * float(nodal.pressure.max()))
    factor_of_other_fits = _BY_OTHERS_OF_TABLE if nodal.tabulated else _BY_OTHERS
    for fit in _OTHER_FITS:
        difference = np.abs(sampled_tractions(nodal, fit).edge_tension() - tension)
        uncertainty = np.maximum(uncertainty, factor_of_other_fits * difference)
    if series.rough:
        uncertainty = np.maximum(uncertainty, _BY_FEW_NODES / len(nodal.x) * np.abs(tension))
    unshortened_series = sampled_tractions(nodal, _UNSHORTENED_FIT)
    difference = np.abs(unshortened_series.edge_tension() - tension)
    uncertainty = np.maximum(uncertainty, difference)
    level_tractions = sampled_tractions(nodal, level=True)
    difference = np.abs(level_tractions.edge_tension() - tension)
    uncertainty = np.maximum(uncertainty, difference)
    if nodal.coupled:
        uncertainty += _BY_COUPLING * spacing_ratio**1.5 * float(np.max(np.abs(tension)))
    of_unseen_slip = np.zeros(2)
    if not (nodal.growing or nodal.slips(RIM + 1)) and math.isfinite(nodal.stick[0]):
        # p at a depth d into the contact is sum k A_k sqrt(2 d/h) there: p^2/d at the nodes of the
        # rim.
        rim_nodes = min(RIM, len(nodal.x) // 2)
        depths = np.array(
            [nodal.x[rim_nodes] - series.edges[0], series.edges[1] - nodal.x[-1 - rim_nodes]]
        )
        rim_pressures = np.array([nodal.pressure[rim_nodes], nodal.pressure[-1 - rim_nodes]])
        of_unseen_slip = _UNSEEN * 8 / math.pi * nodal.friction * rim_pressures * (depths > 0)
    return TractionsAndUncertainty(series, uncertainty + series.placed, of_unseen_slip)


def _series(values: Array) -> Array:
    """Coefficients of the sine series of values at the middles of n equal angles between 0 and pi,
    (n,); the highest is counted once, not twice.

    The discrete sine transform of type II, by that of Fourier of the values continued as an odd
    function: numpy has it, and the import of scipy's takes .06 s.

    >>> _series(np.sin(2 * np.pi * (np.arange(4) + 0.5) / 4)).round(12).tolist()  # the second sine
    [0.0, 1.0, 0.0, 0.0]
    """
    count = len(values)
    waves = np.fft.rfft(np.concatenate([values, -values[::-1]]))[1:]
    to_middles = np.exp(-0.5j * math.pi * np.arange(1, count + 1) / count)
    sines = -np.imag(waves * to_middles) / count
    sines[-1] /= 2
    return sines


def _form(nodal: Nodal) -> Callable[[Array], Array]:
    """A function of x with the shape of p over a smooth function, by the jumps of the profile's
    curvature; 1 everywhere where there are none.

    With x between the edges l and r of contact, phi the angle whose cosine is (b - m)/h, and a jump
    k of h'' at b,

        p = E* k/(2 pi) [phi sqrt((x - l) (r - x)) + (x - b) ln |...|]
            + sqrt((x - l) (r - x)) times what is smooth:

    the slope of p is infinite at b. What is smooth is taken as constant; where that does not leave
    a pressure, the form is 1.

    Source: Muskhelishvili's integral of h' = k max(x - b, 0) over sqrt((x - l) (r - x)).
    """
    left, right = nodal.contact
    middle = (left + right) / 2
    half_width = (right - left) / 2
    kinks = nodal.kinks[np.abs(nodal.kinks[:, 0] - middle) < half_width]

    def of_kinks(x: Array) -> Array:
        """Pressure over the root sqrt(1 - u^2) by jumps of the curvature of the initial gap inside
        the contact.

        x: places (n,), (n,) returned; `kinks` are rows of place and jump of curvature; u is the
        distance from the middle in half-widths.
        """
        # notation: u, t, b places over the half-width from the middle; b > 0
        u = ((x - middle) / half_width).clip(-1 + _AT_EDGE, 1 - _AT_EDGE)
        root = np.sqrt(1 - u**2)
        over_root = np.zeros_like(u)
        for place, jump in kinks.tolist():
            # Of a jump on the left the mirror image: curvature that ends there.
            side = 1.0 if place > middle else -1.0
            b = side * (place - middle) / half_width
            t = side * u
            root_at_b = math.sqrt(1 - b**2)
            distance_from_jump = np.where(t == b, 1.0, t - b)
            logarithm = np.log(np.abs((1 - b * t + root * root_at_b) / distance_from_jump))
            logarithm[t == b] = 0.0
            pressure_of_unit_jump = math.acos(b) + (t - b) * logarithm / root
            over_root += side * jump / (2 * math.pi) * pressure_of_unit_jump
        return over_root

    smooth_part = 0.0
    if len(nodal.x) > 3 * RIM:
        inner_x = nodal.x[RIM:-RIM]
        squared_root = (inner_x - left) * (right - inner_x)
        root = np.sqrt(np.maximum(squared_root, (_AT_EDGE * half_width) ** 2))
        smooth_part = float(np.mean(nodal.pressure[RIM:-RIM] / root - of_kinks(inner_x)))
    if not len(kinks) or not np.all(smooth_part + of_kinks(nodal.x) > 0):
        return np.ones_like
    return lambda x: smooth_part + of_kinks(x)


class _FittedEdge(NamedTuple):
    """A left edge of contact, from p^2 as a polynomial of the distance from the outermost node that
    counts.

    Attributes
    ----------
    edge
        x at which p^2 = 0
    start
        x of the outermost node that counts
    square
        coefficients of p^2, the highest power first
    """

    edge: float
    start: float
    square: Array


def _fitted_edge(x: Array, p: Array, fit: RootFit) -> _FittedEdge | None:
    """The left edge of contact, where p^2, fitted by a polynomial of the distance from the
    outermost nodes that count, is zero; None where no smooth edge is seen.

    x and p are those of the nodes (n,), ascending in x. Half as many nodes are fitted, down to
    `_FEWEST`, while the fit is rough.
    """
    width = x[-1] - x[0]
    # a node at its end, but for round-off, counts
    span_end = x[min(fit.rim, len(x) - 1)] + (_SPAN / 2 + _ROUND_OFF) * width
    nodes_in_span = int(np.searchsorted(x, span_end)) - fit.rim
    n_nodes = round(fit.share * np.clip(nodes_in_span, _USUAL, _MANY_FITTED))
    n_nodes = min(n_nodes, len(x) // 2 - fit.rim)
    while n_nodes >= _FEWEST:
        degree = fit.further_degrees + next(of for fewest, of in _DEGREES if n_nodes >= fewest)
        exponents = np.arange(degree, -1, -1)
        fitted_nodes = slice(fit.rim, fit.rim + n_nodes)
        distance = x[fitted_nodes] - x[fit.rim]
        squared_p = p[fitted_nodes] ** 2
        node_number = np.arange(n_nodes)
        powers = distance[-1] ** exponents
        polynomial = (distance[:, None] ** exponents / powers).T / squared_p
        # what the mesh adds: alternating between corners and mid-side nodes, and dying out
        alternating_signs = (-1.0) ** node_number / (node_number + 4)
        matrix = np.stack([*polynomial, alternating_signs], axis=1) * squared_p[-1]
        fitted_factors = np.linalg.lstsq(matrix, np.ones(n_nodes), rcond=None)[0]
        coefficients = fitted_factors[: degree + 1] * squared_p[-1] / powers
        relative_residual = np.polyval(coefficients, distance) / squared_p - 1
        root_mean_square = math.sqrt(float(np.mean(relative_residual**2)))
        edge_distances = np.roots(coefficients)
        edge_distances = edge_distances[
            (np.abs(edge_distances.imag) < 1e-12) & (edge_distances.real < 0)
        ].real
        if root_mean_square < fit.most_rough and len(edge_distances):
            start = float(x[fit.rim])
            return _FittedEdge(float(x[fit.rim] + edge_distances.max()), start, coefficients)
        n_nodes //= 2
    return None


def _shear(places: Array, pressure: Array, nodal: Nodal, rim: int, level: bool) -> Array:
    """Shear traction q at places (n,) of smoothed `pressure`: +-f p where it slips, elsewhere
    linear in the angle across the stick zone between the nodes that stick, `rim` nodes at either
    end left out.

    Without a slip zone that nodes show, q/p is linear between nodes and on to the edge, or constant
    from the outermost node to the edge where `level`.
    """
    x = nodal.x
    q = nodal.shear
    friction = nodal.friction
    if not nodal.slips(1):
        # q/p has no root at the edge, in full stick and in full slip: linear from node to node, and
        # on to the edge.
        nodal_ratio = q / nodal.pressure
        ratio = np.interp(places, x, nodal_ratio)
        if not level:
            for end_node, next_node, side in ((0, 1, -1.0), (-1, -2, 1.0)):
                is_outside = side * (places - x[end_node]) > 0
                slope = (nodal_ratio[end_node] - nodal_ratio[next_node]) / (
                    x[end_node] - x[next_node]
                )
                ratio[is_outside] += slope * (places[is_outside] - x[end_node])
        return np.asarray(np.clip(ratio, -friction, friction) * pressure)
    left_stick, right_stick = nodal.stick
    limit_left = np.sign(q[0]) * friction
    limit_right = np.sign(q[-1]) * friction
    shear = np.where(places < left_stick, limit_left, limit_right) * pressure
    is_stick_place = (places > left_stick) & (places < right_stick)
    is_stick_node = (x > left_stick) & (x < right_stick)
    is_stick_node[:rim] = False
    is_stick_node[-rim or len(x) :] = False

    def angle(x: Array) -> Array:
        return np.arccos(
            np.clip((left_stick + right_stick - 2 * x) / (right_stick - left_stick), -1, 1)
        )

    shear_at_left, shear_at_right = np.interp([left_stick, right_stick], places, pressure) * [
        limit_left,
        limit_right,
    ]
    shear[is_stick_place] = np.interp(
        angle(places[is_stick_place]),
        np.concatenate([[0.0], angle(x[is_stick_node]), [math.pi]]),
        np.concatenate([[shear_at_left], q[is_stick_node], [shear_at_right]]),
    )
    return np.asarray(shear)


def _unit_missing_shear(places: Array, pressure: Array, lengths: Array, nodal: Nodal) -> Array:
    """A shear traction of unit resultant at places (n,), which stand for `lengths` of the face:
    what the smoothed q lacks of the load is put there.

    Smooth humps within three nodes of the stick edges, since a step of q would stretch the face
    without limit; where nothing slips, of the shape of `pressure`.
    """
    if nodal.slips(1):
        left_stick, right_stick = nodal.stick
        width = 3 * float(np.median(np.diff(nodal.x)))
        distance = np.minimum(np.abs(places - left_stick), np.abs(right_stick - places))
        share_of_width = np.clip(distance / width, 0.0, 1.0)
        hump = np.sin(math.pi * share_of_width) ** 2 * (
            (places > left_stick) & (places < right_stick)
        )
        if hump.any():
            return np.asarray(hump / (lengths @ hump))
    return np.asarray(pressure / (lengths @ pressure))


# ------------------------------------------------------------------- what the size of the body adds


@dataclass(frozen=True, eq=False)
class SizeEffect:
    """What a body of finite size adds to the half-plane's stress.

    Attributes
    ----------
    length
        unit of z, and the distance up to which it holds [length]
    coefficients
        (k, cases) of `size_effect_basis` [stress]
    error
        (cases,) standard error of s_xx at the edge of a contact [stress]
    """

    length: float
    coefficients: Array
    error: Array

    def stress(self, x: Array, y: Array) -> Array:
        """(n, 3, cases) s_xx, s_yy, s_xy [stress]."""
        return np.asarray(size_effect_basis(x + 1j * y, self.length) @ self.coefficients)


def size_effect_basis(z: Complex, length: float) -> Array:
    """(n, 3, k): stress by the terms of a potential sum c_j (z/length)^j that leaves the face free,
    real and imaginary parts.

    s_xx + s_yy = 4 Re f, s_yy - i s_xy = f(z) - f(conj z) + 2 i y conj f'(z); the imaginary c_0 is
    a rotation without stress.
    """
    u = z / length
    columns = []
    for power in range(_TERMS):
        for factor in (1.0, 1j) if power else (1.0,):
            f = factor * u**power
            f_of_conjugate = factor * u.conj() ** power
            slope = factor * power * u ** max(power - 1, 0) / length
            normal_and_shear = f - f_of_conjugate + 2j * z.imag * slope.conj()  # s_yy - i s_xy
            stress = [
                4 * f.real - normal_and_shear.real,
                normal_and_shear.real,
                -normal_and_shear.imag,
            ]
            columns.append(np.stack(stress, axis=-1))
    return np.stack(columns, axis=-1)


def fitted_size_effect(
    x: Array, y: Array, stress: Array, weights: Array, length: float, edge: float
) -> SizeEffect:
    """The size effect from what elements have beyond the half-plane's stress at their nodes.

    Parameters
    ----------
    x, y, weights
        (n,) nodes, y <= 0 from the face, and the area that each stands for
    stress
        (n, 3, cases)
    length
        unit of z [length]
    edge
        half-width of the contact [length]
    """
    root_of_weights = np.sqrt(weights / weights.mean())[:, None, None]
    matrix = (size_effect_basis(x + 1j * y, length) * root_of_weights).reshape(3 * len(x), -1)
    right_side = (stress * root_of_weights).reshape(3 * len(x), -1)
    coefficients, _, rank, _ = np.linalg.lstsq(matrix, right_side, rcond=1e-10)
    residual = right_side - matrix @ coefficients
    deviation = np.sqrt(np.sum(residual**2, axis=0) / max(len(matrix) - rank, 1))
    basis_at_edges = size_effect_basis(np.array([edge + 0j, -edge + 0j]), length)[:, 0]
    covariance = np.linalg.pinv(matrix.T @ matrix)
    variances = np.einsum("ij,jk,ik->i", basis_at_edges, covariance, basis_at_edges)
    return SizeEffect(length, coefficients, deviation * np.sqrt(np.max(variances)))
