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
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from scenes.array_types import Array, Complex

# Outermost nodes of the contact that are the mesh's own.
RIM = 3
# Share of the half-width behind them that p^2 is fitted to on fine meshes: there the error of
# single nodes is left, which many nodes make small.
_FITTED_SPAN = 0.3
# Of the width of the contact: places that differ by less are one.
_ROUND_OFF = 1e-9
# Nodes that p^2 is fitted to: fewest of all, on a coarse mesh, and most.
_FEWEST_FITTED_NODES = 6
_USUAL_FITTED_NODES = 16
_MOST_FITTED_NODES = 100
# Uncertainty of the tension over f p0 in any case, by r, the spacing of the nodes over the
# half-width: what is left of the error of single ones on coarse meshes, in proportion to sqrt(r),
# and on fine ones, where many are fitted, in proportion to r.
_LEAST_ERROR_COARSE = 0.012
_LEAST_ERROR_FINE = 0.036
# Degree of p^2 behind the rim, by the fewest nodes that are fitted with it. On 11 profiles and
# elements of a/160 the tension has an error of 1e-3 at most with the fourth degree; x^5.3 has 2e-2
# with a parabola. Where fewer nodes are fitted, higher degrees follow the error of single ones.
_DEGREE_BY_NODES = ((24, 4), (0, 2))
# Root mean square of the relative residual of p^2 above which fewer nodes are fitted: a corner of
# the profile is among them.
_ROUGH_RESIDUAL = 0.02
FEWEST = 3
"""Fewest nodes in contact whose tractions have a series."""
# Angles over nodes of the contact; at least and at most.
_ANGLES_PER_NODE = 8
_FEWEST_ANGLES = 512
_MOST_ANGLES = 8192
# Size of w^k below which the series ends.
_NEGLIGIBLE_TERM = 1e-10
# Distance from an edge over the half-width at which what is finite there counts as that of the
# edge.
_DISTANCE_AT_EDGE = 1e-9
# Terms of the power series of what the size of a body adds.
_N_TERMS = 7


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
    most_rough: float = _ROUGH_RESIDUAL


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
# The error of the tension over the root mean square of what these change: with the other terms it
# covers 97 of 100 on seeds 242, 243, 250 and 251 of benchmarks/covered.py values, both presets.
_FACTOR_OF_OTHER_FITS = 1.65
# The same of a tabulated profile, whose curvature bends at every point of the table.
_FACTOR_OF_OTHER_FITS_OF_TABLE = 3.3
# Slip zones of so many nodes at most are narrow: there the tension follows the place of the stick
# edge, which is moved by this many distances of nodes.
_NODES_OF_NARROW_ZONE = 6
_STICK_EDGE_MOVED = 0.45
# Share of what slip as narrow as the rim could change that it does change.
_SHARE_OF_UNSEEN_SLIP = 0.7
# Share of the tension, times the nodes in contact, where these are too few to find the edges.
_ERROR_BY_FEW_NODES = 2.0
# Share of the tension, times (spacing of the nodes over the half-width)^(3/2), that the meshes of
# coupled bodies leave: their part of the coupling of p and q bends q at the edges. On coarse meshes
# of blocks and pads, seed 240 of benchmarks/covered.py bodies, 3e-3 to 5e-3 of the tension; on a
# block of four half-widths 1e-3 at a/64, 5e-4 at a/91.
_ERROR_BY_COUPLING = 2.5
# The same of unlike materials: 3e-3 to 2e-2 of the tension on seeds 241 and 243, coarse.
_BY_UNLIKE = 6.0


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
        """Resultants, first and second moments of pressure and of shear about the origin, (6,):
        int p t^k dt for k = 0, 1, 2, then int q t^k dt.

        The first three coefficients of a sine series give the moments about the middle of the
        contact, which are then moved to the origin.
        """
        middle = self.middle
        half_width = self.half_width
        moments_of_both: list[float] = []
        for series in (self.pressure, self.shear):
            resultant = math.pi / 2 * half_width * series[0]
            first_about_middle = -math.pi / 4 * half_width**2 * series[1]
            second_about_middle = math.pi / 8 * half_width**3 * (series[0] + series[2])
            moments_of_both += [
                resultant,
                middle * resultant + first_about_middle,
                middle**2 * resultant + 2 * middle * first_about_middle + second_about_middle,
            ]
        return np.array(moments_of_both)

    def stress(self, x: Array, y: Array) -> Array:
        """Stress s_xx, s_yy, s_xy (n, 3) at n points of the half-plane y <= 0 by the pressure p and
        the shear q on its face, by Muskhelishvili's potentials.

            s_xx = Im A + 2 Re B + D,   s_yy = Im A - D,   D = Re(y A') - Im(y B')
            s_xy = -Im B - Im(y A') - Re(y B')

        # notation: A = sum A_k w^k of the pressure, B = sum B_k w^k of the shear; A', B' slopes in
        # z; w = v - sqrt(v^2 - 1), v = (m - x + i |y|)/h, m middle, h half-width of the contact
        """
        v = (self.middle - x + 0j) / self.half_width
        v.imag = np.abs(y) / self.half_width
        # From above the cut of the root, so that the face counts as inside the body; |w| <= 1.
        root = np.sqrt(v - 1) * np.sqrt(v + 1)
        w = v - root
        A, B, *slope_sums = _sums(np.stack([self.pressure, self.shear]), w)
        with np.errstate(divide="ignore", invalid="ignore"):
            # dw/dz = w/(h root)
            y_slope_A, y_slope_B = np.where(
                y == 0, 0.0, y * np.array(slope_sums) / (self.half_width * root)
            )
        D = y_slope_A.real - y_slope_B.imag
        s_xx = A.imag + 2 * B.real + D
        s_yy = A.imag - D
        s_xy = -B.imag - y_slope_A.imag - y_slope_B.real
        return np.stack([s_xx, s_yy, s_xy], axis=-1)


def _sums(series: Array, w: Complex) -> Complex:
    """Sum two power series and their slopes at n complex points: sum A_k w^k, sum B_k w^k,
    sum k A_k w^k and sum k B_k w^k over k = 1, 2, ..., (4, n).

    Horner's rule, at each point from the last term that is not negligible there. Points are sorted
    by their number of terms, longest first, so that the points with a term k are the first ones.

    Parameters
    ----------
    series
        (2, n_terms) coefficients A_k and B_k from k = 1 on
    w
        (n,) points, |w| <= 1
    """
    n_terms = series.shape[1]
    exponents = np.arange(1, n_terms + 1)
    with np.errstate(divide="ignore"):
        terms_to_negligible = math.log(_NEGLIGIBLE_TERM) / np.log(np.minimum(np.abs(w), 1 - 1e-12))
        terms_needed = np.minimum(np.ceil(terms_to_negligible), n_terms).astype(int)
    longest_first = np.argsort(-terms_needed, kind="stable")
    terms_needed = np.maximum(terms_needed[longest_first], 1)
    w_longest_first = w[longest_first]
    coefficients = np.concatenate([series, exponents * series])
    partial_sums = np.zeros((4, len(w)), dtype=complex)
    points_with_term = np.searchsorted(-terms_needed, -exponents, side="right")
    for k in range(int(terms_needed.max(initial=0)), 0, -1):
        n_points = points_with_term[k - 1]
        partial_sums[:, :n_points] += coefficients[:, k - 1, None]
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
    coupled, unlike
        whether p and q act on each other: bodies of two shapes or materials; of two materials
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
    unlike: bool = False

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
        """Stress s_xx at the left and right edge of contact by a shear traction q at n angles
        theta_j across it, (2,) [stress].

        It is 2 sum_k B_k and 2 sum_k (-1)^k B_k of the sine series of q, each as one weighted sum
        over angles. With B_k = (2/n) sum_j q_j sin(k theta_j), the highest once, and
        cos(n theta_j) = 0,

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
    """Sine series of pressure and shear across the contact, from their values at the nodes that
    touch.

    `fit` is how p^2 is fitted behind the edges to find them. `level`: whether q/p, where the whole
    contact sticks or slips, stays constant from the outermost node to the edge.
    """
    return sampled_tractions(nodal, fit, level).series()


def sampled_tractions(
    nodal: Nodal, fit: RootFit = _USUAL_FIT, level: bool = False
) -> SampledTractions:
    """Smooth pressure and shear at equal angles across the contact, from their values at the nodes
    that touch, whose outermost ones the mesh distorts.

    With x = m - h cos(theta), n angles theta lie between the edges. These are where p^2, fitted
    behind the outermost nodes, is zero; with too few nodes those that the solution states. What the
    smooth shear lacks of the load Q is placed at the stick edges.

    # notation: m middle, h half-width of the contact

    Parameters
    ----------
    nodal
        pressure and shear at the nodes, edges, friction, and jumps of the profile's curvature
    fit
        how p^2 is fitted behind the edges
    level
        whether q/p stays constant from the outermost node to the edge, instead of following its
        slope, where the whole contact sticks or slips
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
    sine = np.sin(theta)
    places = middle - half_width * np.cos(theta)
    behind_rims = slice(None) if rough else slice(fit.rim, -fit.rim)
    inner_x = x[behind_rims]
    inner_p = p_over_form[behind_rims]
    is_in_contact = np.abs(inner_x - middle) < half_width
    angle = np.arccos((middle - inner_x[is_in_contact]) / half_width)
    # p/sin(theta) is finite at the edges of a smooth profile.
    p_over_sine = np.interp(theta, angle, inner_p[is_in_contact] / np.sin(angle))
    smooth_pressure = p_over_sine * sine
    if fit_at_left is not None and fit_at_right is not None:
        # Beyond the outermost nodes that count, p is the root of the fitted p^2.
        for side, fit_at_edge in ((1.0, fit_at_left), (-1.0, fit_at_right)):
            is_beyond_start = side * places < fit_at_edge.start
            squared_p = np.polyval(
                fit_at_edge.square, side * places[is_beyond_start] - fit_at_edge.start
            )
            smooth_pressure[is_beyond_start] = np.sqrt(np.maximum(squared_p, 0.0))
    smooth_pressure = smooth_pressure * form(places)
    shear = _shear(places, smooth_pressure, nodal, 0 if rough else fit.rim, level)
    lengths = sine * half_width * math.pi / n_angles  # of the face, for each angle
    missing_load = nodal.tangential_load - float(lengths @ shear)
    missing_shear = _unit_missing_shear(places, smooth_pressure, lengths, nodal) * missing_load
    return SampledTractions(edges, theta, smooth_pressure, shear, missing_shear, rough)


def tension_of_nodes(nodal: Nodal) -> float:
    """Quick estimate, to a tenth, of the larger tension |s_xx| at the two edges of contact, by the
    shear q at the nodes [stress].

    It is (2/pi) int q cot(theta/2) d theta at the left edge and (2/pi) int q tan(theta/2) d theta
    at the right one, with theta from x = m - h cos(theta). The integrand is taken as constant
    between an edge and its outermost node.

    # notation: m middle, h half-width of the contact that the solution states
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
    """Sine series of pressure and shear across the contact, from their values at the nodes, and the
    uncertainty of the tension s_xx at both edges.

    None and zeros where fewer than three nodes touch.
    """
    if len(nodal.x) < FEWEST:
        return TractionsAndUncertainty(None, np.zeros(2), np.zeros(2))
    series = tractions(nodal)
    uncertainty = _tension_uncertainty(nodal, series)
    return TractionsAndUncertainty(series, uncertainty, _tension_of_unseen_slip(nodal, series))


def _tension_uncertainty(nodal: Nodal, series: Tractions) -> Array:
    """Uncertainty of the tension s_xx at both edges of contact, (2,) [stress], by how much other
    fits of the same nodal values change it.

    The largest of these counts: a share of f p0 by the spacing of the nodes, with a multiple of
    what other numbers of nodes or a higher degree of the polynomial change, the root mean square of
    these; what a fit through rough values changes; a q/p that stays constant near the edges. Added
    are the tension by what q lacked of the load, the error by the meshes of coupled bodies, and
    what other stick edges change where slip zones are narrow.

    `series` are the tractions by the usual fit.
    """
    tension = series.edge_tension()
    spacing = float(np.median(np.diff(nodal.x)))
    spacing_ratio = spacing / series.half_width
    least_uncertainty_ratio = min(
        _LEAST_ERROR_COARSE * math.sqrt(spacing_ratio), _LEAST_ERROR_FINE * spacing_ratio
    )
    least_uncertainty = least_uncertainty_ratio * nodal.friction * float(nodal.pressure.max())
    factor_of_other_fits = (
        _FACTOR_OF_OTHER_FITS_OF_TABLE if nodal.tabulated else _FACTOR_OF_OTHER_FITS
    )
    changes = [sampled_tractions(nodal, fit).edge_tension() - tension for fit in _OTHER_FITS]
    by_other_fits = factor_of_other_fits * np.sqrt(np.mean(np.square(changes), axis=0))
    uncertainty = least_uncertainty + by_other_fits
    if series.rough:
        uncertainty = np.maximum(uncertainty, _ERROR_BY_FEW_NODES / len(nodal.x) * np.abs(tension))
    unshortened_series = sampled_tractions(nodal, _UNSHORTENED_FIT)
    difference = np.abs(unshortened_series.edge_tension() - tension)
    uncertainty = np.maximum(uncertainty, difference)
    level_tractions = sampled_tractions(nodal, level=True)
    difference = np.abs(level_tractions.edge_tension() - tension)
    uncertainty = np.maximum(uncertainty, difference)
    if nodal.coupled:
        factor_of_coupling = _BY_UNLIKE if nodal.unlike else _ERROR_BY_COUPLING
        uncertainty += factor_of_coupling * spacing_ratio**1.5 * float(np.max(np.abs(tension)))
    if nodal.slips(1) and not nodal.slips(_NODES_OF_NARROW_ZONE + 1):
        uncertainty += _by_stick_edges(nodal, _STICK_EDGE_MOVED * spacing, tension)
    return uncertainty + series.placed


def _tension_of_unseen_slip(nodal: Nodal, series: Tractions) -> Array:
    """Change of the tension s_xx at both edges, (2,) [stress], by a slip zone so narrow that no
    node lies in it, as there is one just after a load has turned.

    Such slip changes q by 2 f p with p = K sqrt(d), so s_xx by (8/pi) f K sqrt(w); K sqrt(w) is the
    pressure at the first node behind the outermost ones (the rim). Zero where nodes show the slip
    zone, where P grows in full stick, and in full slip.

    # notation: d distance from the edge, K constant of the pressure there, w width of the rim
    """
    if nodal.growing or nodal.slips(1) or not math.isfinite(nodal.stick[0]):
        return np.zeros(2)
    rim_nodes = min(RIM, len(nodal.x) // 2)
    depths = np.array(
        [nodal.x[rim_nodes] - series.edges[0], series.edges[1] - nodal.x[-1 - rim_nodes]]
    )
    rim_pressures = np.array([nodal.pressure[rim_nodes], nodal.pressure[-1 - rim_nodes]])
    return np.asarray(
        _SHARE_OF_UNSEEN_SLIP * 8 / math.pi * nodal.friction * rim_pressures * (depths > 0)
    )


def _by_stick_edges(nodal: Nodal, distance: float, tension: Array) -> Array:
    """Change of the tension s_xx at both edges of contact, (2,) [stress], if the stick edges lay a
    `distance` farther in or farther out, the larger of both.

    `nodal` has the tractions at the nodes and the stick edges; `tension` (2,) is that with the
    edges as they are.
    """
    left_edge, right_edge = nodal.stick
    changes = []
    for move_inwards in (distance, -distance):
        moved_left = max(left_edge + move_inwards, nodal.contact[0])
        moved_right = min(right_edge - move_inwards, nodal.contact[1])
        if moved_left < moved_right:
            moved_nodal = replace(nodal, stick=(moved_left, moved_right))
            changes.append(np.abs(sampled_tractions(moved_nodal).edge_tension() - tension))
    return np.asarray(np.max(changes, axis=0, initial=0.0))


def _series(values: Array) -> Array:
    """Coefficients (n,) of the sine series through n values at the middles of n equal angles
    between 0 and pi: the discrete sine transform of type II.

    The values are continued as an odd function and transformed by numpy's real Fourier transform,
    since the import of scipy's sine transform takes 0.06 s. The highest coefficient is halved, as
    its sine is sampled at its extremes.

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
    """A function of x that bends as the pressure p does at jumps of the profile's curvature, so
    that p over it is smooth enough to fit; 1 everywhere where there are no jumps.

    With a jump k of h'' at x = b, the slope of p is infinite there:

        p = E* k/(2 pi) [phi R + (x - b) ln |...|] + R (smooth part),   R = sqrt((x - l) (r - x))

    The smooth part is taken as constant, the mean over the nodes. Where that makes p negative
    somewhere, the function is 1.

    # notation: h profile, l, r edges of contact, m its middle, a its half-width,
    # cos(phi) = (b - m)/a

    Source: Muskhelishvili's integral of h' = k max(x - b, 0) over R.
    """
    left, right = nodal.contact
    middle = (left + right) / 2
    half_width = (right - left) / 2
    kinks = nodal.kinks[np.abs(nodal.kinks[:, 0] - middle) < half_width]

    def of_kinks(x: Array) -> Array:
        """Pressure by the jumps of curvature inside the contact, over the root sqrt(1 - u^2), at
        places x (n,): (n,) [stress].

        # notation: u, t, b distances from the middle over the half-width: of a place, of its mirror
        # image if the jump lies on the left, and of the jump (b > 0)
        """
        u = ((x - middle) / half_width).clip(-1 + _DISTANCE_AT_EDGE, 1 - _DISTANCE_AT_EDGE)
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
        root = np.sqrt(np.maximum(squared_root, (_DISTANCE_AT_EDGE * half_width) ** 2))
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
    """Left edge of contact by extrapolation of the pressure: p^2 near a smooth edge is linear in
    the distance, so a polynomial fitted to p^2 is zero there. None where no smooth edge is seen.

    The outermost nodes, which the mesh distorts, are left out. While the fit is rough (a corner of
    the profile may be near), half as many nodes are fitted, down to six.

    Parameters
    ----------
    x, p
        (n,) places of the touching nodes, ascending, and the pressure there
    fit
        how many nodes are left out, how many fitted, the degree, and what counts as rough
    """
    width = x[-1] - x[0]
    # Fitted nodes lie on a span of a share of the half-width; one at its very end counts.
    span_end = x[min(fit.rim, len(x) - 1)] + (_FITTED_SPAN / 2 + _ROUND_OFF) * width
    nodes_in_span = int(np.searchsorted(x, span_end)) - fit.rim
    n_nodes = round(fit.share * np.clip(nodes_in_span, _USUAL_FITTED_NODES, _MOST_FITTED_NODES))
    n_nodes = min(n_nodes, len(x) // 2 - fit.rim)
    while n_nodes >= _FEWEST_FITTED_NODES:
        degree = fit.further_degrees + next(
            of for fewest, of in _DEGREE_BY_NODES if n_nodes >= fewest
        )
        exponents = np.arange(degree, -1, -1)
        fitted_nodes = slice(fit.rim, fit.rim + n_nodes)
        distance = x[fitted_nodes] - x[fit.rim]
        squared_p = p[fitted_nodes] ** 2
        node_number = np.arange(n_nodes)
        powers = distance[-1] ** exponents
        polynomial = (distance[:, None] ** exponents / powers).T / squared_p
        # What the mesh adds alternates between corners and mid-side nodes, and dies out.
        mesh_error = (-1.0) ** node_number / (node_number + 4)
        matrix = np.stack([*polynomial, mesh_error], axis=1) * squared_p[-1]
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
    """Smooth shear traction q across the contact, (n,), from its values at the nodes: +-f p in the
    slip zones, interpolated over the angle across the stick zone.

    Where no node shows a slip zone, q/p is interpolated instead and continued to the edges.

    Parameters
    ----------
    places, pressure
        (n,) x across the contact, and the smooth pressure there
    nodal
        pressure and shear at the nodes, stick edges, friction
    rim
        number of outermost nodes on either side whose q is left out, as the mesh distorts it
    level
        whether q/p is continued to the edges as constant, not by its slope
    """
    x = nodal.x
    q = nodal.shear
    friction = nodal.friction
    if not nodal.slips(1):
        # In full stick and in full slip q/p is finite at the edge: linear from node to node, and on
        # to the edge.
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
        """0 at the left stick edge, pi at the right one."""
        cosine = (left_stick + right_stick - 2 * x) / (right_stick - left_stick)
        return np.arccos(np.clip(cosine, -1, 1))

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
    """Shear traction (n,) of unit resultant, concentrated at the stick edges: there a smooth fit of
    q lacks a part of the load Q.

    It has two smooth humps within three nodes of the stick edges, since a jump of q would make the
    tension infinite. Where nothing slips, it has the shape of the pressure.

    Parameters
    ----------
    places, lengths
        (n,) x across the contact, and the length of face that each stands for
    pressure
        (n,) smooth pressure there
    nodal
        x of the nodes and stick edges
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
    """Stress s_xx, s_yy, s_xy at n points of a half-plane with a free face, (n, 3, k), by each of
    the k terms of a power-series potential f = sum_j c_j (z/length)^j.

        s_xx + s_yy = 4 Re f,   s_yy - i s_xy = f(z) - f(conj z) + 2 i y conj f'(z)

    Each c_j counts twice, with factor 1 and i; the imaginary c_0 is a rotation without stress. `z`
    is x + i y, y <= 0.
    """
    u = z / length
    columns = []
    for power in range(_N_TERMS):
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
    """Least-squares fit, by a power-series potential, of the stress that a body of finite size has
    beyond that of a half-plane, with the standard error of s_xx at the edges of contact.

    Parameters
    ----------
    x, y, weights
        (n,) nodes, y <= 0 counted from the face, and the area that each stands for
    stress
        (n, 3, cases) stress of the elements minus that of the half-plane: s_xx, s_yy, s_xy
    length
        unit of the potential's argument, and the distance up to which the fit holds [length]
    edge
        x of the right edge of contact, whose left edge is at -x [length]
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
