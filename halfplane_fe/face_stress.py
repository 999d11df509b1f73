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

It is half-plane theory inside the finite elements, as the far field is. What a body of finite size
adds is a field without tractions on a flat face: a power series sum_k c_k z^k of the potential. It
is fitted to the stress of the elements minus that integral where they are accurate, a little below
the face and beside the contact.

The mesh distorts p at the outermost three nodes on each side. There p comes from a fit of p^2 to
the nodes further inside, since p^2 grows in proportion to the distance from a smooth edge; the edge
of contact is where this fit is 0. At jumps of the profile's curvature the slope of p is infinite: p
over a function with the same slope (`_pressure_shape`) is what is fitted. The mesh error alternates
between corners and mid-side nodes and dies out: a term of that form is fitted with the polynomial
of p^2, and left out. In the slip zones q = +-f p.

Source: Muskhelishvili (1953), Some Basic Problems of the Mathematical Theory of Elasticity; Johnson
(1985), section 2.5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from scenes.array_types import Array, Complex, Mask

# Outermost nodes on each side of the contact whose tractions the mesh distorts.
N_DISTORTED_NODES = 3
# Length inside them, over the half-width, on which p^2 is fitted on fine meshes: there only the
# error of single nodes is left, which many nodes make small.
_FITTED_SPAN = 0.3
# Places that differ by less, over the width of the contact, are one.
_ROUND_OFF = 1e-9
# Difference over the largest pressure that is round-off error: with it a pressure is still its own
# mirror image.
_SAME_PRESSURE = 1e-13
# Number of nodes that p^2 is fitted to: fewest of all, on a coarse mesh, and most.
_FEWEST_FITTED_NODES = 6
_USUAL_FITTED_NODES = 16
_MOST_FITTED_NODES = 100
# Least uncertainty of the tension over f p0 and sqrt(r), r the spacing of the nodes over the
# half-width: the error of single nodes that is left where all fits agree by chance.
_LEAST_TENSION_ERROR = 0.0035
# Degree of the polynomial of p^2, by the fewest nodes that are fitted with it. On 11 profiles and
# elements of a/160 the tension has an error of 1e-3 at most with the fourth degree; x^5.3 has 2e-2
# with a parabola. Where fewer nodes are fitted, higher degrees follow the error of single ones.
_DEGREE_BY_NODES = ((24, 4), (0, 2))
# Root mean square of the relative residual of p^2 above which fewer nodes are fitted: a corner of
# the profile is near.
_LARGEST_RESIDUAL = 0.02
FEWEST_NODES = 3
"""Fewest nodes in contact whose tractions are expanded in a series."""
# Number of angles over that of nodes in contact; fewest and most angles.
_ANGLES_PER_NODE = 8
_FEWEST_ANGLES = 512
_MOST_ANGLES = 8192
# Size of w^k below which the terms of a series are left out.
_NEGLIGIBLE_TERM = 1e-10
# Distance from an edge over the half-width at which values with a finite limit are taken for those
# at the edge.
_DISTANCE_AT_EDGE = 1e-9
# Terms of the power series for the stress that the finite size of a body adds.
_N_TERMS = 7


class EdgeFit(NamedTuple):
    """How p^2 is fitted inside an edge of contact, to find that edge.

    Attributes
    ----------
    nodes_left_out
        number of outermost nodes that are left out
    share_of_nodes
        number of nodes fitted, over the usual number on this mesh
    further_degrees
        degree of the polynomial, minus the usual degree for so many nodes
    largest_residual
        root mean square of the relative residual above which half as many nodes are fitted
    """

    nodes_left_out: int = N_DISTORTED_NODES
    share_of_nodes: float = 1.0
    further_degrees: int = 0
    largest_residual: float = _LARGEST_RESIDUAL


_USUAL_FIT = EdgeFit()
# Other fits, whose results show how uncertain the tension is. The polynomial lacks the higher
# powers that p^2 has above a flat bottom: half as many nodes, or one degree more, leave less of
# that error. So do other numbers of nodes left out on coarse meshes, which fit fewer nodes.
_OTHER_FITS = (
    EdgeFit(nodes_left_out=2, share_of_nodes=0.7),
    EdgeFit(nodes_left_out=4),
    EdgeFit(share_of_nodes=0.5),
    EdgeFit(further_degrees=1),
)
# Fit to the usual number of nodes, also where its residual is so large that fewer are fitted: it
# has the larger error there.
_FIT_WHATEVER_RESIDUAL = EdgeFit(largest_residual=math.inf)
# Error of the tension over the mean of its changes by the other fits, in which a single poor fit
# does not prevail: with the other terms it covers 98 of 100 on seeds 321, 286 and 401 to 403 of
# benchmarks/covered.py values, both presets.
_FACTOR_OF_OTHER_FITS = 1.9
# The same of a tabulated profile, whose curvature bends at every point of the table.
_FACTOR_OF_OTHER_FITS_OF_TABLE = 3.6
# Error of the tension over that by the shear that the fit lacked: it may have its place elsewhere.
# Fitted with the factors above.
_FACTOR_OF_MISSING_SHEAR = 1.1
# Slip zones of so many nodes at most are narrow: there the tension follows the place of the stick
# edge, which is moved by this many distances of nodes.
_MOST_NODES_OF_NARROW_ZONE = 6
_STICK_EDGE_SHIFT_IN_SPACINGS = 0.15
# Change of the tension by slip as narrow as the outermost nodes, over its largest possible value.
_COUNTED_SHARE_OF_UNSEEN_SLIP = 0.7
# Relative error of the tension, times the number of nodes in contact, where these are too few to
# find the edges.
_RELATIVE_ERROR_TIMES_NODES = 2.0
# Relative error of the tension over the spacing of the nodes over the half-width, of real bodies:
# their size bends p and q at the edges. Layers, blocks, pads and cylinders, seeds 284 to 286 of
# benchmarks/covered.py bodies, coarse: up to 0.37; the other terms cover a part.
_RELATIVE_ERROR_PER_SPACING_OF_REAL_BODIES = 0.22
# The same of unlike materials: 3e-3 to 2e-2 of the tension on seeds 241 and 243, coarse.
_RELATIVE_ERROR_PER_SPACING_OF_UNLIKE_MATERIALS = 1.05


@dataclass(frozen=True, eq=False)
class Tractions:
    """Pressure p and shear q across one contact at one instant, as sine series of the angle theta.

    Attributes
    ----------
    edges
        x at the left and right edge of contact [length]
    pressure_coefficients, shear_coefficients
        (k,) coefficients A_k and B_k from k = 1 on [stress]
    has_unfitted_edges
        whether too few nodes touch to find the edges from p^2: those of the solution stand
    tension_by_missing_shear
        larger change of the tension s_xx at the two edges by the part of the load Q that a smooth
        fit of q lacks, which is added at the stick edges [stress]
    """

    edges: tuple[float, float]
    pressure_coefficients: Array
    shear_coefficients: Array
    has_unfitted_edges: bool
    tension_by_missing_shear: float = 0.0

    @property
    def middle(self) -> float:
        """Middle m of the contact [length]."""
        return sum(self.edges) / 2

    @property
    def half_width(self) -> float:
        """Half-width h of the contact [length]."""
        return (self.edges[1] - self.edges[0]) / 2

    def edge_tension(self) -> Array:
        """Tension s_xx of the lower body at the left and right edge of contact, (2,) [stress]:
        2 sum B_k and 2 sum (-1)^k B_k, B_k the coefficients of the sine series of shear.
        """
        return np.array(
            [
                2 * self.shear_coefficients.sum(),
                2 * self.shear_coefficients[1::2].sum() - 2 * self.shear_coefficients[::2].sum(),
            ]
        )

    def moments(self) -> Array:
        """Resultants, first and second moments of pressure p and of shear q about the origin x = 0,
        (6,): int p x^k dx for k = 0, 1, 2, then int q x^k dx, across the contact.

        The first three coefficients of a sine series give the moments about the middle of the
        contact, which are then moved to the origin.
        """
        middle = self.middle  # of the contact
        half_width = self.half_width
        moments_of_both: list[float] = []
        # coefficients of sin(k theta) from k = 1 on, with x = middle - half_width cos(theta)
        for series in (self.pressure_coefficients, self.shear_coefficients):
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

        # notation: A = sum A_k w^k of the pressure, B = sum B_k w^k of the shear, with the
        # coefficients A_k, B_k of their sine series; A', B' derivatives in
        # z = x + i y; w = v - sqrt(v^2 - 1), v = (m - x + i |y|)/h, m middle, h half-width of the
        # contact
        """
        v = (self.middle - x + 0j) / self.half_width
        v.imag = np.abs(y) / self.half_width
        # From above the cut of the root, so that the face counts as inside the body; |w| <= 1.
        root = np.sqrt(v - 1) * np.sqrt(v + 1)
        w = v - root
        # A, B, w dA/dw and w dB/dw at each point
        A, B, w_slope_A, w_slope_B = _power_sums(
            np.stack([self.pressure_coefficients, self.shear_coefficients]), w
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            # y dA/dz = y (w dA/dw)/(h root), since dw/dz = w/(h root)
            y_slope_A, y_slope_B = np.where(
                y == 0, 0.0, y * np.array([w_slope_A, w_slope_B]) / (self.half_width * root)
            )
        D = y_slope_A.real - y_slope_B.imag
        s_xx = A.imag + 2 * B.real + D
        s_yy = A.imag - D
        s_xy = -B.imag - y_slope_A.imag - y_slope_B.real
        return np.stack([s_xx, s_yy, s_xy], axis=-1)


def _power_sums(series: Array, w: Complex) -> Complex:
    """Sums of two power series and w times their derivatives at n complex points, (4, n): sum A_k
    w^k, sum B_k w^k, sum k A_k w^k and sum k B_k w^k over k = 1, 2, ....

    Horner's rule, at each point from the last k whose |w|^k is not negligible, that is above 1e-10.
    Points are sorted by their number of terms, largest first, so that the points with a term k are
    the first ones.

    Parameters
    ----------
    series
        (2, n_terms) coefficients A_k and B_k from k = 1 on
    w
        (n,) points, |w| <= 1
    """
    # Number of terms that each point needs.
    n_terms = series.shape[1]
    exponents = np.arange(1, n_terms + 1)
    with np.errstate(divide="ignore"):
        # _NEGLIGIBLE_TERM: size of w^k below which terms are left out, 1e-10
        terms_to_negligible = math.log(_NEGLIGIBLE_TERM) / np.log(np.minimum(np.abs(w), 1 - 1e-12))
        terms_needed = np.minimum(np.ceil(terms_to_negligible), n_terms).astype(int)

    # Horner's rule over all points at once, in the order of these numbers.
    order_by_terms = np.argsort(-terms_needed, kind="stable")
    terms_needed = np.maximum(terms_needed[order_by_terms], 1)
    sorted_w = w[order_by_terms]
    coefficients = np.concatenate([series, exponents * series])  # (4, n_terms)
    partial_sums = np.zeros((4, len(w)), dtype=complex)
    n_points_with_term = np.searchsorted(-terms_needed, -exponents, side="right")
    for k in range(int(terms_needed.max(initial=0)), 0, -1):
        n_points = n_points_with_term[k - 1]
        partial_sums[:, :n_points] += coefficients[:, k - 1, None]
        partial_sums[:, :n_points] *= sorted_w[:n_points]
    sums = np.empty_like(partial_sums)
    sums[:, order_by_terms] = partial_sums
    return sums


@dataclass(frozen=True, eq=False)
class NodalTractions:
    """Pressure and shear at the nodes that touch at one instant, with what their smoothing needs.

    Attributes
    ----------
    x, pressure, shear
        (n,) places of the nodes [length], p and q there [stress]
    stick_edges, contact_edges
        x at the left and right edge of the stick zone (NaN in full slip) and of contact, as the
        solution states them [length]
    friction
        coefficient f
    tangential_load
        resultant of q: what the smooth q lacks of it is added at the stick edges
        [force per thickness]
    load_grows_in_stick
        whether P grows by |dQ|/f at least, so that nothing slips: there is no slip zone between
        the nodes either
    curvature_jumps
        (k, 2) x at which the curvature of the profile jumps, and E* times its jump from left to
        right [length, stress/length]
    has_tabulated_profile
        whether the profile is a curve through points
    has_real_bodies, has_unlike_materials
        whether one body at least is of finite size; whether the materials differ
    """

    x: Array
    pressure: Array
    shear: Array
    stick_edges: tuple[float, float]
    contact_edges: tuple[float, float]
    friction: float
    tangential_load: float
    load_grows_in_stick: bool
    curvature_jumps: Array = field(default_factory=lambda: np.empty((0, 2)))
    has_tabulated_profile: bool = False
    has_real_bodies: bool = False
    has_unlike_materials: bool = False

    def has_slip_zones(self, *, of_nodes: int) -> bool:
        """Whether there is a stick zone between two slip zones of at least `of_nodes` nodes each,
        among the touching nodes at `x`, ascending; in full slip the stick edges are NaN.

        In full stick they are the edges of contact, which may lie inside the outermost nodes.
        """
        left_stick_edge, right_stick_edge = self.stick_edges
        left_edge, right_edge = self.contact_edges
        # _ROUND_OFF: of places, over the width of the contact
        same_edge = _ROUND_OFF * (right_edge - left_edge)
        return (
            len(self.x) > of_nodes
            and math.isfinite(left_stick_edge)
            and left_stick_edge > self.x[of_nodes - 1]
            and right_stick_edge < self.x[-of_nodes]
            and left_stick_edge > left_edge + same_edge
            and right_stick_edge < right_edge - same_edge
        )


@dataclass(frozen=True, eq=False)
class SampledTractions:
    """Smooth pressure p and shear q of one instant at equal angles across the contact: enough for
    the tension at its edges.

    Attributes
    ----------
    edges
        x at the left and right edge of contact [length]
    theta
        (n,) middles of n equal angles from the left edge to the right one
    pressure, shear
        (n,) p and q [stress]
    missing_shear
        (n,) shear that is added at the stick edges, whose resultant is what the smooth q lacks of
        the load Q [stress]
    has_unfitted_edges
        whether too few nodes touch to find the edges from p^2: those of the solution stand
    """

    edges: tuple[float, float]
    theta: Array
    pressure: Array
    shear: Array
    missing_shear: Array
    has_unfitted_edges: bool

    def edge_tension(self) -> Array:
        """Tension s_xx of the lower body at the left and right edge of contact, (2,) [stress], by
        the smooth shear and what that lacks of the load Q.
        """
        return self._edge_tension_by_shear(self.shear + self.missing_shear)

    def tension_by_missing_shear(self) -> float:
        """Larger change of the tension s_xx at the two edges of contact by the shear that is added
        to the smooth one, whose resultant lacked a part of the load Q [stress].
        """
        return float(np.abs(self._edge_tension_by_shear(self.missing_shear)).max())

    def _edge_tension_by_shear(self, shear: Array) -> Array:
        """Stress s_xx (2,) along the face of the lower body at its left and right edge of contact,
        by a shear traction q at n angles theta_j across the contact; positive in tension [stress].

        The angles are the middles of n equal parts of 0 to pi (`theta`), from the left edge to the
        right one. A half-plane has 2 sum_k B_k and 2 sum_k (-1)^k B_k at the edges, B_k the sine
        coefficients of q. With B_k = (2/n) sum_j q_j sin(k theta_j), half of it for k = n, and
        cos(n theta_j) = 0, each is one weighted sum over the angles:

            2 sum_k B_k = (2/n) sum_j q_j cot(theta_j/2),
            2 sum_k (-1)^k B_k = -(2/n) sum_j q_j tan(theta_j/2)
        """
        half_angle_tangent = np.tan(self.theta / 2)
        return (
            2
            / len(shear)
            * np.array([np.sum(shear / half_angle_tangent), -np.sum(shear * half_angle_tangent)])
        )

    def sine_series(self) -> Tractions:
        """Pressure p and shear q as sine series of the angle across the contact; q with the part
        that its smooth fit lacked of the load Q.
        """
        return Tractions(
            self.edges,
            pressure_coefficients=_sine_series(self.pressure),
            shear_coefficients=_sine_series(self.shear) + _sine_series(self.missing_shear),
            has_unfitted_edges=self.has_unfitted_edges,
            tension_by_missing_shear=self.tension_by_missing_shear(),
        )


def tractions(nodal_tractions: NodalTractions) -> Tractions:
    """Sine series of pressure and shear across the contact, from their values at the nodes that
    touch, by the usual fit of the edges.
    """
    return sampled_tractions(nodal_tractions).sine_series()


def sampled_tractions(
    nodal_tractions: NodalTractions,
    fit_settings: EdgeFit = _USUAL_FIT,
    constant_ratio: bool = False,
) -> SampledTractions:
    """Smooth pressure and shear at equal angles across the contact, from their values at the nodes
    that touch. The mesh distorts those at the outermost nodes, which are left out.

    At n angles theta, x = m - h cos(theta). The edges of contact are where p^2, fitted inside the
    outermost nodes, is zero. Where either edge of contact has no such fit, both are those that the
    solution states, and no node is left out. Before the fit p is divided by a function with the
    same steep slopes at kinks of the profile (`_pressure_shape`). What the smooth shear lacks of
    the load Q is returned apart, as a shear traction at the stick edges.

    # notation: m middle, h half-width of the contact

    Parameters
    ----------
    nodal_tractions
        pressure and shear at the nodes that touch (`x` their places), edges of contact and stick
        that the solution states, friction, load Q (`tangential_load`), and jumps of the profile's
        curvature
    fit_settings
        how p^2 is fitted inside the edges of contact, after `nodes_left_out` outermost nodes on
        each side
    constant_ratio
        whether q/p stays constant from the outermost node to the edge of contact, instead of
        following its slope, where the whole contact sticks or slips
    """
    # Edges of contact by the fit. `pressure_shape` is the function of x that p is divided by.
    x = nodal_tractions.x
    pressure_shape = _pressure_shape(nodal_tractions)
    p_over_shape = nodal_tractions.pressure / pressure_shape(x)
    fitted_edges = _fitted_edges(x, p_over_shape, fit_settings)
    if fitted_edges is None:
        contact_edges = nodal_tractions.contact_edges
        nodes_left_out = 0
    else:
        # The right edge of contact is found as the left one of p(-x).
        contact_edges = (fitted_edges[0].edge, -fitted_edges[1].edge)
        nodes_left_out = fit_settings.nodes_left_out
    # Smooth pressure and shear, and the part of Q that this lacks as a shear at the stick edges.
    points = _PointsAcross.between(contact_edges, len(x))
    inner_nodes = slice(nodes_left_out, len(x) - nodes_left_out)
    smooth_p_over_shape = _smooth_pressure(
        points, x[inner_nodes], p_over_shape[inner_nodes], fitted_edges
    )
    pressure = smooth_p_over_shape * pressure_shape(points.places)
    shear = _smooth_shear(points.places, pressure, nodal_tractions, nodes_left_out, constant_ratio)
    missing_load = nodal_tractions.tangential_load - float(points.lengths @ shear)
    missing_shear = (
        _unit_missing_shear(points.places, pressure, points.lengths, nodal_tractions) * missing_load
    )
    return SampledTractions(
        contact_edges,
        points.theta,
        pressure,
        shear,
        missing_shear,
        has_unfitted_edges=fitted_edges is None,
    )


class _PointsAcross(NamedTuple):
    """Points at the middles of n equal angles theta across the contact, x = m - h cos(theta).

    # notation: m middle, h half-width of the contact

    Attributes
    ----------
    middle, half_width
        of the contact [length]
    theta
        (n,) angles, from the left edge to the right one
    places, lengths
        (n,) x at each angle, and the length of face that it stands for [length]
    """

    middle: float
    half_width: float
    theta: Array
    places: Array
    lengths: Array

    @classmethod
    def between(cls, edges: tuple[float, float], n_nodes: int) -> _PointsAcross:
        """Points between the left and right edge of contact, eight for each of the `n_nodes` nodes
        that touch: 512 at least and 8192 at most. They lie at x = m - h cos(theta). The range 0 to
        pi of theta is divided into equal parts, each with one point in its middle. `lengths` are
        the lengths of face that the points stand for.

        # notation: m middle, h half-width of the contact
        """
        middle = (edges[0] + edges[1]) / 2
        half_width = (edges[1] - edges[0]) / 2
        n_angles = int(np.clip(_ANGLES_PER_NODE * n_nodes, _FEWEST_ANGLES, _MOST_ANGLES))
        theta = math.pi * (np.arange(n_angles) + 0.5) / n_angles
        return cls(
            middle,
            half_width,
            theta,
            places=middle - half_width * np.cos(theta),
            lengths=np.sin(theta) * half_width * math.pi / n_angles,
        )


def _smooth_pressure(
    points: _PointsAcross,
    inner_x: Array,
    inner_p: Array,
    fitted_edges: tuple[_FittedEdge, _FittedEdge] | None,
) -> Array:
    """Smooth pressure at points across the contact, (n,): interpolated between inner nodes; outside
    the outermost fitted nodes it is the root of the polynomial fitted to p^2.

    p/sin(theta) is interpolated over the angle theta, since it is finite at the edges of a smooth
    profile.

    Parameters
    ----------
    points
        angles and places x of the points
    inner_x, inner_p
        places of the inner nodes, ascending, without outermost ones that the mesh distorts, and the
        pressure there, or the pressure over a function of x, as is then returned
    fitted_edges
        fits of p^2 at the left edge, and at the right edge of the mirror image in x = 0; None where
        the edges are not fitted
    """
    is_in_contact = np.abs(inner_x - points.middle) < points.half_width
    node_angles = np.arccos((points.middle - inner_x[is_in_contact]) / points.half_width)
    p_over_sine = np.interp(points.theta, node_angles, inner_p[is_in_contact] / np.sin(node_angles))
    pressure = p_over_sine * np.sin(points.theta)
    if fitted_edges is not None:
        for side, fitted_edge in zip((1.0, -1.0), fitted_edges, strict=True):
            is_outside = side * points.places < fitted_edge.outermost_node_x
            squared_p = np.polyval(
                fitted_edge.squared_pressure_coefficients,
                side * points.places[is_outside] - fitted_edge.outermost_node_x,
            )
            pressure[is_outside] = np.sqrt(np.maximum(squared_p, 0.0))
    return np.asarray(pressure)


def edge_tension_by_nodal_shear(nodal_tractions: NodalTractions) -> float:
    """Quick estimate, to a tenth, of the larger tension |s_xx| at the two edges of contact, by the
    shear q at the nodes [stress].

    It is (2/pi) int q cot(theta/2) d theta at the left edge and (2/pi) int q tan(theta/2) d theta
    at the right one, with theta from x = m - h cos(theta). The integrand is taken as constant
    between an edge and its outermost node. 0 where no node lies inside the edges.

    # notation: m middle, h half-width of the contact that the solution states (`contact_edges`)
    """
    left_edge, right_edge = nodal_tractions.contact_edges
    middle = (left_edge + right_edge) / 2
    half_width = (right_edge - left_edge) / 2
    is_inside = np.abs(nodal_tractions.x - middle) < half_width
    angles = np.arccos((middle - nodal_tractions.x[is_inside]) / half_width)
    shear = nodal_tractions.shear[is_inside]
    if not len(shear):
        return 0.0
    half_angle_tangent = np.tan(angles / 2)
    tensions = []
    for weighted_shear in (shear / half_angle_tangent, shear * half_angle_tangent):
        integral_between_nodes = np.trapezoid(weighted_shear, angles)
        integral_to_edges = weighted_shear[0] * angles[0] + weighted_shear[-1] * (
            math.pi - angles[-1]
        )
        tensions.append(2 / math.pi * abs(float(integral_between_nodes + integral_to_edges)))
    return max(tensions)


class TractionsAndUncertainty(NamedTuple):
    """Sine series of the tractions at one instant, with the uncertainty of the tension at either
    edge.

    Attributes
    ----------
    tractions
        pressure and shear; None where fewer than three nodes touch
    tension_uncertainty
        (2,) uncertainty of the tension s_xx at the left and right edge, by the fit [stress]
    tension_change_by_unseen_slip
        (2,) change of this tension by a slip zone just after a load has reversed, so narrow that no
        node lies in it [stress]
    """

    tractions: Tractions | None
    tension_uncertainty: Array
    tension_change_by_unseen_slip: Array


def tractions_with_uncertainty(nodal_tractions: NodalTractions) -> TractionsAndUncertainty:
    """Sine series of pressure and shear across the contact, from their values at the nodes that
    touch, and the uncertainty of the tension s_xx at both edges of contact by the fit.

    Also the change of that tension by slip in a zone too narrow for the nodes. None and zeros where
    fewer than three nodes touch. `nodal_tractions` also has the edges of contact and
    stick, friction and Q.
    """
    # FEWEST_NODES: 3
    if len(nodal_tractions.x) < FEWEST_NODES:
        return TractionsAndUncertainty(None, np.zeros(2), np.zeros(2))
    usual_tractions = tractions(nodal_tractions)
    return TractionsAndUncertainty(
        usual_tractions,
        _tension_uncertainty(nodal_tractions, usual_tractions),
        tension_change_by_unseen_slip(nodal_tractions, usual_tractions),
    )


def _tension_uncertainty(nodal_tractions: NodalTractions, usual_tractions: Tractions) -> Array:
    """Uncertainty of the tension s_xx at both edges of contact, (2,) [stress]: how much other fits
    of the same nodal values change it.

    The largest of these counts; multiples are by constant factors, chosen on many solutions:

    - a least uncertainty in proportion to f p0, plus a multiple of the mean change by fits to other
      numbers of nodes or of a higher degree;
    - a multiple of the tension, where there are too few nodes to find the edges of contact;
    - the change by a fit to the usual number of nodes, whatever its residual;
    - the change by a ratio q/p that stays constant near the edges of contact.

    To this come the mesh error of bodies of finite size, the change by other stick edges where slip
    zones are narrow (six nodes at most), and a multiple of the tension by the shear that the fit
    lacked.

    # notation: p0 largest nodal pressure, f coefficient of friction

    Parameters
    ----------
    nodal_tractions
        pressure and shear at the nodes that touch; whether the profile is a table of points, a body
        of finite size, the materials unlike
    usual_tractions
        sine series of both by the usual fit; whether the edges of contact are not fitted but those
        of the solution (`has_unfitted_edges`); tension by the shear that it lacked
    """
    tension = usual_tractions.edge_tension()  # (2,) at the left and right edge of contact
    spacing = float(np.median(np.diff(nodal_tractions.x)))  # of the nodes
    spacing_ratio = spacing / usual_tractions.half_width
    uncertainty = _uncertainty_by_other_fits(nodal_tractions, tension, spacing_ratio)

    # Too few nodes to find the edges of contact; a fit without limit on its residual; constant q/p.
    # _RELATIVE_ERROR_TIMES_NODES: multiple, over the number of nodes
    if usual_tractions.has_unfitted_edges:
        uncertainty = np.maximum(
            uncertainty, _RELATIVE_ERROR_TIMES_NODES / len(nodal_tractions.x) * np.abs(tension)
        )
    for other_tractions in (
        sampled_tractions(nodal_tractions, _FIT_WHATEVER_RESIDUAL),
        sampled_tractions(nodal_tractions, constant_ratio=True),
    ):
        uncertainty = np.maximum(uncertainty, np.abs(other_tractions.edge_tension() - tension))

    # Added: mesh error of unlike materials or bodies of finite size; place of the stick edges.
    # _STICK_EDGE_SHIFT_IN_SPACINGS: by how many spacings of the nodes the edges are moved
    uncertainty += (
        _relative_error_per_spacing(nodal_tractions)
        * spacing_ratio
        * float(np.max(np.abs(tension)))
    )
    has_slip_zones = nodal_tractions.has_slip_zones(of_nodes=1)
    has_wide_slip_zones = nodal_tractions.has_slip_zones(of_nodes=_MOST_NODES_OF_NARROW_ZONE + 1)
    if has_slip_zones and not has_wide_slip_zones:
        uncertainty += _tension_change_by_moved_stick_edges(
            nodal_tractions, _STICK_EDGE_SHIFT_IN_SPACINGS * spacing, tension
        )
    return uncertainty + _FACTOR_OF_MISSING_SHEAR * usual_tractions.tension_by_missing_shear


def _uncertainty_by_other_fits(
    nodal_tractions: NodalTractions, tension: Array, spacing_ratio: float
) -> Array:
    """Uncertainty of the tension s_xx at both edges of contact by the choice of the fit, (2,)
    [stress]: a multiple of its mean change by four other fits, plus a least uncertainty.

    The other fits take fewer nodes, leave out other numbers of nodes, or have a higher degree. The
    least uncertainty is in proportion to f p0 and the root of the relative spacing.

    # notation: p0 largest nodal pressure, f coefficient of friction

    Parameters
    ----------
    nodal_tractions
        pressure and shear at the nodes that touch, friction; whether the profile is a table of
        points, which has a larger multiple
    tension
        (2,) by the usual fit [stress]
    spacing_ratio
        distance of the nodes over the contact half-width
    """
    largest_coulomb_limit = nodal_tractions.friction * float(nodal_tractions.pressure.max())
    # _LEAST_TENSION_ERROR: share of f p0 and the root of the relative spacing
    least_uncertainty = _LEAST_TENSION_ERROR * math.sqrt(spacing_ratio) * largest_coulomb_limit
    # Factors chosen on many solutions: 3.6 of a tabulated profile, else 1.9.
    factor_of_other_fits = (
        _FACTOR_OF_OTHER_FITS_OF_TABLE
        if nodal_tractions.has_tabulated_profile
        else _FACTOR_OF_OTHER_FITS
    )
    # _OTHER_FITS: the four other fits
    changes = [
        sampled_tractions(nodal_tractions, fit).edge_tension() - tension for fit in _OTHER_FITS
    ]
    change_by_other_fits = factor_of_other_fits * np.mean(np.abs(changes), axis=0)
    return np.asarray(least_uncertainty + change_by_other_fits)


def _relative_error_per_spacing(nodal_tractions: NodalTractions) -> float:
    """Relative error of the edge tension by the mesh, over the spacing of the nodes over the
    half-width: fitted values for unlike materials and for bodies of finite size; 0 for half-planes
    of one material.
    """
    if nodal_tractions.has_unlike_materials:
        return _RELATIVE_ERROR_PER_SPACING_OF_UNLIKE_MATERIALS
    if nodal_tractions.has_real_bodies:
        return _RELATIVE_ERROR_PER_SPACING_OF_REAL_BODIES
    return 0.0


def tension_change_by_unseen_slip(
    nodal_tractions: NodalTractions, smooth_tractions: Tractions
) -> Array:
    """Change of the tension s_xx at both edges of contact, (2,) [stress], by a slip zone so narrow
    that no node lies in it, as there is one just after a load has reversed.

    Such slip changes q by 2 f p with p = K sqrt(d), so s_xx by (8/pi) f K sqrt(w); K sqrt(w) is the
    pressure at the first node inside the three distorted outermost ones. A share of 0.7 of this
    counts. Zero where P grows in full stick, and in full slip. Zero too where nodes slip on both
    sides, but for a side whose outermost node has shear of the other sign than its slip zone: new
    slip in that direction may have begun.

    # notation: f coefficient of friction, d distance from the edge of contact, K constant of the
    # pressure there, w width of the zone of the distorted nodes

    Parameters
    ----------
    nodal_tractions
        pressure and shear at the nodes that touch (`x` their places, ascending), stick edges (NaN
        in full slip), friction, and whether P grows in full stick (`load_grows_in_stick`)
    smooth_tractions
        their sine series, of which the edges of contact are used
    """
    left_stick_edge, right_stick_edge = nodal_tractions.stick_edges
    if nodal_tractions.load_grows_in_stick or not math.isfinite(left_stick_edge):
        return np.zeros(2)

    # Whether such slip is possible at the left and the right edge of contact.
    x = nodal_tractions.x
    pressure = nodal_tractions.pressure
    may_slip_unseen = np.array([True, True])
    if nodal_tractions.has_slip_zones(of_nodes=1):  # nodes slip on both sides of a stick zone
        shear = nodal_tractions.shear
        shear_of_zones = np.array(
            [shear[x < left_stick_edge].sum(), shear[x > right_stick_edge].sum()]
        )
        may_slip_unseen = shear[[0, -1]] * shear_of_zones < 0

    # Pressure K sqrt(w) on either side, at the node that is number `inner_node` from the end.
    # N_DISTORTED_NODES: three outermost nodes on each side, which the mesh distorts
    inner_node = min(N_DISTORTED_NODES, len(x) // 2)
    distances_inside = np.array(
        [x[inner_node] - smooth_tractions.edges[0], smooth_tractions.edges[1] - x[-1 - inner_node]]
    )
    inner_pressures = np.array([pressure[inner_node], pressure[-1 - inner_node]])
    # _COUNTED_SHARE_OF_UNSEEN_SLIP: 0.7
    factor = _COUNTED_SHARE_OF_UNSEEN_SLIP * 8 / math.pi * nodal_tractions.friction
    return np.asarray(factor * inner_pressures * (may_slip_unseen & (distances_inside > 0)))


def _tension_change_by_moved_stick_edges(
    nodal_tractions: NodalTractions, distance: float, tension: Array
) -> Array:
    """Change of the tension s_xx at both edges of contact, (2,) [stress], if both stick edges lay a
    `distance` [length] further inside or further outside: the larger one. They stay in the contact;
    where they would meet, they are not moved.

    `nodal_tractions` are pressure and shear at the nodes, with the edges of stick and contact.
    `tension` (2,) is that with the stick edges where these have them [stress].
    """
    left_stick_edge, right_stick_edge = nodal_tractions.stick_edges
    changes = []
    for inward_distance in (distance, -distance):
        moved_left_stick_edge = max(
            left_stick_edge + inward_distance, nodal_tractions.contact_edges[0]
        )
        moved_right_stick_edge = min(
            right_stick_edge - inward_distance, nodal_tractions.contact_edges[1]
        )
        if moved_left_stick_edge < moved_right_stick_edge:
            tractions_with_moved_stick = replace(
                nodal_tractions, stick_edges=(moved_left_stick_edge, moved_right_stick_edge)
            )
            moved_tension = sampled_tractions(tractions_with_moved_stick).edge_tension()
            changes.append(np.abs(moved_tension - tension))
    return np.asarray(np.max(changes, axis=0, initial=0.0))


def _sine_series(values: Array) -> Array:
    """Coefficients (n,) of the sine series through n values at the middles of n equal angles
    between 0 and pi: the discrete sine transform of type II.

    The values are continued as an odd function and transformed by numpy's real Fourier transform,
    since the import of scipy's sine transform takes 0.06 s. The highest coefficient is halved, as
    its sine is sampled at its extremes.

    >>> _sine_series(np.sin(2 * np.pi * (np.arange(4) + 0.5) / 4)).round(
    ...     12
    ... ).tolist()  # the second sine
    [0.0, 1.0, 0.0, 0.0]
    """
    n_values = len(values)
    odd_spectrum = np.fft.rfft(np.concatenate([values, -values[::-1]]))[1:]
    # The values lie half an angle off the points that the Fourier transform takes.
    phase_shift = np.exp(-0.5j * math.pi * np.arange(1, n_values + 1) / n_values)
    coefficients = -np.imag(odd_spectrum * phase_shift) / n_values
    coefficients[-1] /= 2
    return coefficients


def _pressure_shape(nodal_tractions: NodalTractions) -> Callable[[Array], Array]:
    """Function of x, (n,) -> (n,), that p is divided by before a fit: it has the infinite slopes
    that the pressure p has at jumps of the profile's curvature. Without jumps it is 1 everywhere.

    With a jump c of h'' at x = m + a b, b > 0, the slope of p is infinite there:

        p = E* c/(2 pi) a [R arccos b + (t - b) ln |(1 - b t + R B)/(t - b)|] + R (smooth part),
        t = (x - m)/a,   R = sqrt(1 - t^2),   B = sqrt(1 - b^2)

    The function is p/(a R) with the smooth part taken as constant, its mean over the nodes. Where
    this is not positive at every node, the function is 1.

    # notation: h profile, m middle of the contact, a its half-width, E* contact modulus

    `nodal_tractions` are pressure at the nodes that touch, edges of contact that the solution
    states, and `curvature_jumps` (k, 2): places of the jumps and E* times each, left subtracted
    from right.

    Source: Muskhelishvili's integral of h' = c max(x - b, 0) over R.
    """
    left_edge, right_edge = nodal_tractions.contact_edges
    middle = (left_edge + right_edge) / 2
    half_width = (right_edge - left_edge) / 2
    curvature_jumps = nodal_tractions.curvature_jumps
    inner_curvature_jumps = curvature_jumps[np.abs(curvature_jumps[:, 0] - middle) < half_width]
    if not len(inner_curvature_jumps):
        return np.ones_like

    def pressure_over_root_by_jumps(x: Array) -> Array:
        """Pressure at places x (n,) by the jumps of the profile's curvature, over the half-width
        times R.
        """
        return _pressure_over_root_by_jumps(x, middle, half_width, inner_curvature_jumps)

    # Mean of p/(a R) minus that of the jumps, over the nodes but for the three outermost ones on
    # either side. The root is a R.
    # _DISTANCE_AT_EDGE: least distance from an edge of contact over the half-width, 1e-9
    smooth_p_over_root = 0.0
    # N_DISTORTED_NODES: three outermost nodes on each side, which the mesh distorts
    if len(nodal_tractions.x) > 3 * N_DISTORTED_NODES:
        inner_x = nodal_tractions.x[N_DISTORTED_NODES:-N_DISTORTED_NODES]
        squared_root = (inner_x - left_edge) * (right_edge - inner_x)
        half_width_times_root = np.sqrt(
            np.maximum(squared_root, (_DISTANCE_AT_EDGE * half_width) ** 2)
        )
        smooth_p_over_root = float(
            np.mean(
                nodal_tractions.pressure[N_DISTORTED_NODES:-N_DISTORTED_NODES]
                / half_width_times_root
                - pressure_over_root_by_jumps(inner_x)
            )
        )
    if not np.all(smooth_p_over_root + pressure_over_root_by_jumps(nodal_tractions.x) > 0):
        return np.ones_like
    return lambda x: smooth_p_over_root + pressure_over_root_by_jumps(x)


def _pressure_over_root_by_jumps(
    x: Array, middle: float, half_width: float, curvature_jumps: Array
) -> Array:
    """Pressure at places x (n,) by jumps of the profile's curvature inside the contact, over the
    half-width times sqrt(1 - u^2), (n,) [stress / length].

    # notation: u, t, b distances from the middle over the half-width: of a place, of its mirror
    # image if the jump lies on the left, and of the jump (b > 0)

    Parameters
    ----------
    x
        places; those at an edge, or beyond it, are taken a little inside [length]
    middle, half_width
        of the contact [length]
    curvature_jumps
        (k, 2) places of the jumps, and contact modulus times each jump from left to right
    """
    # _DISTANCE_AT_EDGE: least distance from an edge over the half-width, 1e-9
    u = ((x - middle) / half_width).clip(-1 + _DISTANCE_AT_EDGE, 1 - _DISTANCE_AT_EDGE)
    root = np.sqrt(1 - u**2)
    pressure_over_root = np.zeros_like(u)
    for place, modulus_times_jump in curvature_jumps.tolist():
        # A jump on the left is the mirror image of one on the right, of opposite sign.
        side = 1.0 if place > middle else -1.0
        b = side * (place - middle) / half_width
        t = side * u
        root_at_b = math.sqrt(1 - b**2)
        distance_from_jump = np.where(t == b, 1.0, t - b)
        logarithm = np.log(np.abs((1 - b * t + root * root_at_b) / distance_from_jump))
        logarithm[t == b] = 0.0
        ratio_by_unit_jump = math.acos(b) + (t - b) * logarithm / root
        pressure_over_root += side * modulus_times_jump / (2 * math.pi) * ratio_by_unit_jump
    return pressure_over_root


class _FittedEdge(NamedTuple):
    """Left edge of contact, from a polynomial of p^2 in the distance from the outermost fitted
    node.

    Attributes
    ----------
    edge
        x at which the polynomial is 0 [length]
    outermost_node_x
        x of the outermost fitted node [length]
    squared_pressure_coefficients
        coefficients of the polynomial, the highest power first
    """

    edge: float
    outermost_node_x: float
    squared_pressure_coefficients: Array


def _fitted_edges(
    x: Array, p: Array, fit_settings: EdgeFit
) -> tuple[_FittedEdge, _FittedEdge] | None:
    """Left and right edge of contact by extrapolation of the pressure p (n,) from nodes at x (n,),
    ascending: each with the polynomial of p^2 that is zero there. The right one is mirrored in
    x = 0: it is the left edge of p(-x). None where the fit of either fails.

    `fit_settings` states how many outermost nodes are left out, how many are fitted, and by which
    degree.
    """
    mirrored_x = -x[::-1]
    mirrored_p = p[::-1]
    left_edge = _fitted_edge(x, p, fit_settings)
    # A pressure that is its own mirror image has one fit for both edges.
    # _SAME_PRESSURE: round-off, 1e-13
    is_mirrored = np.array_equal(mirrored_x, x) and bool(
        np.max(np.abs(mirrored_p - p)) <= _SAME_PRESSURE * np.max(p)
    )
    mirrored_right_edge = (
        left_edge if is_mirrored else _fitted_edge(mirrored_x, mirrored_p, fit_settings)
    )
    if left_edge is None or mirrored_right_edge is None:
        return None
    return left_edge, mirrored_right_edge


def _fitted_edge(x: Array, p: Array, fit_settings: EdgeFit) -> _FittedEdge | None:
    """Left edge of contact by extrapolation of the pressure: p^2 near a smooth edge is linear in
    the distance from it, so a polynomial fitted to p^2 is zero there. None where no polynomial
    fits.

    The outermost nodes, which the mesh distorts, are left out. Nodes are fitted over 0.3 of the
    half-width: 16 of them at least, 100 at most, none beyond the middle. While the residual is
    large (a corner of the profile may be near), or the polynomial has no zero outside the nodes,
    half as many are fitted. With fewer than six there is no fit. The degree is 4 from 24 nodes on,
    else 2.

    Parameters
    ----------
    x, p
        (n,) places of the touching nodes, ascending [length], and the pressure there, over a
        function that has its infinite slopes at kinks of the profile; of a right edge both are
        mirrored in x = 0
    fit_settings
        how many nodes are left out, factor on the number of nodes that are fitted, what is added to
        the degree, and the largest root mean square of the relative residual

    Returns
    -------
    _FittedEdge or None
        x of the edge, x of the outermost fitted node, and the coefficients of the polynomial in the
        distance from this node, highest power first.
    """
    n_nodes = _number_of_fitted_nodes(x, fit_settings)
    while n_nodes >= _FEWEST_FITTED_NODES:
        # _DEGREE_BY_NODES: fewest nodes and degree, highest first
        degree = fit_settings.further_degrees + next(
            usual_degree
            for fewest_nodes, usual_degree in _DEGREE_BY_NODES
            if n_nodes >= fewest_nodes
        )
        fitted_nodes = slice(fit_settings.nodes_left_out, fit_settings.nodes_left_out + n_nodes)
        distance_from_node = x[fitted_nodes] - x[fit_settings.nodes_left_out]
        squared_p = p[fitted_nodes] ** 2
        coefficients = _squared_pressure_polynomial(distance_from_node, squared_p, degree)
        relative_residual = np.polyval(coefficients, distance_from_node) / squared_p - 1
        root_mean_square = math.sqrt(float(np.mean(relative_residual**2)))

        # The edge is the nearest real zero outside the outermost fitted node.
        roots = np.roots(coefficients)
        edge_distances = roots[(np.abs(roots.imag) < 1e-12) & (roots.real < 0)].real
        if root_mean_square < fit_settings.largest_residual and len(edge_distances):
            outermost_node_x = float(x[fit_settings.nodes_left_out])
            edge = float(x[fit_settings.nodes_left_out] + edge_distances.max())
            return _FittedEdge(edge, outermost_node_x, coefficients)
        n_nodes //= 2
    return None


def _number_of_fitted_nodes(x: Array, fit_settings: EdgeFit) -> int:
    """Number of nodes that p^2 is fitted to first, inside the outermost ones that are left out:
    those within 0.3 of the half-width, times the share of the fit.

    The usual number is 16 at least and 100 at most; no node beyond the middle is fitted. `x` (n,)
    are places of the touching nodes, ascending [length].
    """
    width = x[-1] - x[0]
    # A node at the very end of the span counts. _FITTED_SPAN: share of the half-width, 0.3
    end_of_fit = (
        x[min(fit_settings.nodes_left_out, len(x) - 1)] + (_FITTED_SPAN / 2 + _ROUND_OFF) * width
    )
    nodes_available = int(np.searchsorted(x, end_of_fit)) - fit_settings.nodes_left_out
    # _USUAL_FITTED_NODES: 16; _MOST_FITTED_NODES: 100
    n_nodes = round(
        fit_settings.share_of_nodes
        * np.clip(nodes_available, _USUAL_FITTED_NODES, _MOST_FITTED_NODES)
    )
    return min(n_nodes, len(x) // 2 - fit_settings.nodes_left_out)


def _squared_pressure_polynomial(distance: Array, squared_p: Array, degree: int) -> Array:
    """Coefficients (degree + 1,) of the polynomial of the distance from the outermost fitted node
    that fits p^2 at n nodes with the least relative residuals; highest power first.

    The mesh error of p^2 alternates between corner nodes and mid-side nodes of the elements, and
    dies out. A term of that form is fitted with the polynomial, and left out.

    Parameters
    ----------
    distance
        (n,) of the nodes from the outermost fitted one, ascending from 0
    squared_p
        (n,) p^2 at the nodes
    degree
        of the polynomial
    """
    n_nodes = len(distance)
    node_number = np.arange(n_nodes)
    exponents = np.arange(degree, -1, -1)
    # Terms over p^2, whose sum is to be 1. Scaled powers keep the matrix well-conditioned.
    largest_powers = distance[-1] ** exponents
    polynomial_terms = (distance[:, None] ** exponents / largest_powers).T / squared_p
    mesh_error_term = (-1.0) ** node_number / (node_number + 4)
    matrix = np.stack([*polynomial_terms, mesh_error_term], axis=1) * squared_p[-1]
    scaled_coefficients = np.linalg.lstsq(matrix, np.ones(n_nodes), rcond=None)[0]
    return np.asarray(scaled_coefficients[: degree + 1] * squared_p[-1] / largest_powers)


def _smooth_shear(
    places: Array,
    pressure: Array,
    nodal_tractions: NodalTractions,
    nodes_left_out: int,
    constant_ratio: bool,
) -> Array:
    """Smooth shear traction q across the contact, (n,) [stress], from its values at the nodes. In
    the slip zones it is +-f p where nodes slip; across the stick zone it is interpolated over the
    angle.

    Unless nodes slip on both sides of a stick zone, q/p is interpolated instead, continued to the
    edges of contact, and kept within +-f: so in full stick and in full slip.

    Parameters
    ----------
    places, pressure
        (n,) x across the contact, and the smooth pressure there
    nodal_tractions
        pressure and shear at the nodes that touch (`x` their places, ascending), stick edges (NaN
        in full slip), friction
    nodes_left_out
        number of outermost nodes on either side whose q is left out, as the mesh distorts it
    constant_ratio
        whether q/p is continued to the edges of contact as constant, not by its slope
    """
    # Unless a stick zone lies between two slip zones of one node at least.
    if not nodal_tractions.has_slip_zones(of_nodes=1):
        ratio = _ratio_without_slip_zones(places, nodal_tractions, constant_ratio)
        friction = nodal_tractions.friction
        return np.asarray(np.clip(ratio, -friction, friction) * pressure)

    # Slip zones on the left and on the right: q/p by their nodes.
    x = nodal_tractions.x
    left_stick_edge, right_stick_edge = nodal_tractions.stick_edges
    shear_by_left_zone = pressure * _ratio_in_slip_zone(
        places, nodal_tractions, x < left_stick_edge, nodes_left_out
    )
    shear_by_right_zone = pressure * _ratio_in_slip_zone(
        places, nodal_tractions, x > right_stick_edge, nodes_left_out
    )
    shear = np.where(places < left_stick_edge, shear_by_left_zone, shear_by_right_zone)

    # Stick zone: interpolated between the shear at its edges.
    is_in_stick = (places > left_stick_edge) & (places < right_stick_edge)
    shear_at_stick_edges = (
        float(np.interp(left_stick_edge, places, shear_by_left_zone)),
        float(np.interp(right_stick_edge, places, shear_by_right_zone)),
    )
    shear[is_in_stick] = _shear_in_stick_zone(
        places[is_in_stick], nodal_tractions, nodes_left_out, shear_at_stick_edges
    )
    return np.asarray(shear)


def _ratio_without_slip_zones(
    places: Array, nodal_tractions: NodalTractions, constant_ratio: bool
) -> Array:
    """q/p at places (n,) across a contact in full stick or in full slip, where it is finite at the
    edges of contact: linear between nodes, and from the outermost node to the edge.

    Parameters
    ----------
    places
        (n,) x across the contact [length]
    nodal_tractions
        pressure and shear at the nodes that touch, `x` their places, ascending
    constant_ratio
        whether q/p is constant from the outermost node to the edge of contact, not by its slope
    """
    x = nodal_tractions.x
    nodal_ratio = nodal_tractions.shear / nodal_tractions.pressure
    ratio = np.interp(places, x, nodal_ratio)
    if constant_ratio:
        return ratio
    for end_node, next_node, side in ((0, 1, -1.0), (-1, -2, 1.0)):
        is_outside = side * (places - x[end_node]) > 0
        slope = (nodal_ratio[end_node] - nodal_ratio[next_node]) / (x[end_node] - x[next_node])
        ratio[is_outside] += slope * (places[is_outside] - x[end_node])
    return ratio


def _shear_in_stick_zone(
    places: Array,
    nodal_tractions: NodalTractions,
    nodes_left_out: int,
    shear_at_stick_edges: tuple[float, float],
) -> Array:
    """Shear q at places (n,) in the stick zone [stress]: interpolated over the angle across it,
    between the zone's edges and its undistorted nodes.

    Parameters
    ----------
    places
        (n,) x between the edges of the stick zone [length]
    nodal_tractions
        shear at the nodes that touch (`x` their places, ascending), and both stick edges
    nodes_left_out
        number of outermost nodes of the contact, on either side, whose q is left out
    shear_at_stick_edges
        q at the left and right stick edge [stress]
    """
    x = nodal_tractions.x
    left_stick_edge, right_stick_edge = nodal_tractions.stick_edges
    is_stick_node = (x > left_stick_edge) & (x < right_stick_edge)
    is_stick_node[:nodes_left_out] = False
    is_stick_node[len(x) - nodes_left_out :] = False

    def angle_in_zone(x_in_zone: Array) -> Array:
        """Angle across the stick zone at places: 0 at its left edge, pi at its right one."""
        cosine = (left_stick_edge + right_stick_edge - 2 * x_in_zone) / (
            right_stick_edge - left_stick_edge
        )
        return np.arccos(np.clip(cosine, -1, 1))

    shear_at_left_edge, shear_at_right_edge = shear_at_stick_edges
    shear_at_nodes = nodal_tractions.shear[is_stick_node]
    return np.interp(
        angle_in_zone(places),
        np.concatenate([[0.0], angle_in_zone(x[is_stick_node]), [math.pi]]),
        np.concatenate([[shear_at_left_edge], shear_at_nodes, [shear_at_right_edge]]),
    )


def _ratio_in_slip_zone(
    places: Array, nodal_tractions: NodalTractions, is_in_zone: Mask, nodes_left_out: int
) -> Array:
    """q/p at places (n,) of a slip zone: linear between its nodes, which have +-f where they slip,
    and less where slip has ended from the edge of contact inwards.

    It leaves out the outermost nodes of the contact, which the mesh distorts, and the node next to
    the stick zone, which may stick. Where no other is left, q/p is f with the sign of the shear of
    all the zone: just before it opens, the outermost node alone may have the other sign.

    Parameters
    ----------
    places
        (n,) x [length]; q/p is constant beyond the outermost and the innermost node that is used
    nodal_tractions
        pressure and shear at the nodes that touch (`x` their places, ascending), friction f
    is_in_zone
        (n_nodes,) which of the touching nodes lie in the zone, at one end of the contact
    nodes_left_out
        number of outermost nodes of the contact, on either side, that are left out
    """
    zone_nodes = np.flatnonzero(is_in_zone)
    n_nodes = len(nodal_tractions.x)
    is_at_left = zone_nodes[0] == 0
    nodes_but_next_to_stick = zone_nodes[:-1] if is_at_left else zone_nodes[1:]
    is_undistorted = (nodes_but_next_to_stick >= nodes_left_out) & (
        nodes_but_next_to_stick < n_nodes - nodes_left_out
    )
    inner_nodes = nodes_but_next_to_stick[is_undistorted]
    if not len(inner_nodes):
        sign = np.sign(nodal_tractions.shear[zone_nodes].sum())
        return np.full(len(places), sign * nodal_tractions.friction)
    nodal_ratio = nodal_tractions.shear[inner_nodes] / nodal_tractions.pressure[inner_nodes]
    return np.asarray(np.interp(places, nodal_tractions.x[inner_nodes], nodal_ratio))


def _unit_missing_shear(
    places: Array, pressure: Array, lengths: Array, nodal_tractions: NodalTractions
) -> Array:
    """Shear traction (n,) of unit resultant next to the stick edges, where a smooth fit of q lacks
    a part of the load Q [1 / length].

    It has two smooth humps in the stick zone, within three node distances of its edges, since a
    jump of q would make the tension infinite. Unless nodes slip on both sides of a stick zone, it
    has the shape of the pressure: so in full stick and in full slip.

    Parameters
    ----------
    places, lengths
        (n,) x across the contact, and the length of face that each stands for
    pressure
        (n,) smooth pressure there
    nodal_tractions
        x of the nodes that touch, and left and right edge of the stick zone
    """
    # A stick zone lies between two slip zones of one node at least.
    if nodal_tractions.has_slip_zones(of_nodes=1):
        left_stick_edge, right_stick_edge = nodal_tractions.stick_edges
        hump_width = 3 * float(np.median(np.diff(nodal_tractions.x)))
        distance = np.minimum(np.abs(places - left_stick_edge), np.abs(right_stick_edge - places))
        relative_distance = np.clip(distance / hump_width, 0.0, 1.0)
        hump = np.sin(math.pi * relative_distance) ** 2 * (
            (places > left_stick_edge) & (places < right_stick_edge)
        )
        if hump.any():
            return np.asarray(hump / (lengths @ hump))
    return np.asarray(pressure / (lengths @ pressure))


# ------------------------------------------------------ stress that the finite size of a body adds


@dataclass(frozen=True, eq=False)
class SizeEffect:
    """Stress that a body of finite size has beyond that of a half-plane: a power-series potential.

    Attributes
    ----------
    length
        unit of z, and the distance from the middle up to which the series holds [length]
    coefficients
        (k, cases) coefficients of the terms of `size_effect_basis` [stress]
    error
        (cases,) standard error of s_xx at the edge of a contact [stress]
    """

    length: float
    coefficients: Array
    error: Array

    def stress(self, x: Array, y: Array) -> Array:
        """Stress s_xx, s_yy, s_xy that the finite size of a body adds at n points, for each load
        case, (n, 3, cases) [stress]: a sum of terms z^j with fitted coefficients.
        """
        return np.asarray(size_effect_basis(x + 1j * y, self.length) @ self.coefficients)


def size_effect_basis(z: Complex, length: float) -> Array:
    """Stress s_xx, s_yy, s_xy at n points of a half-plane with a free face, (n, 3, k), by each of
    the k terms of a power-series potential f = sum_j c_j (z/length)^j.

        s_xx + s_yy = 4 Re f,   s_yy - i s_xy = f(z) - f(conj z) + 2 i y conj f'(z)

    There are seven powers j = 0 to 6 (`_N_TERMS`). Real and imaginary part of each c_j are two
    terms, with factor 1 and i; the imaginary c_0 is left out, a rotation without stress. `z` (n,)
    is x + i y, y <= 0; `length` is its unit [length].

    # notation: f potential, conj complex conjugate, f' derivative in z, u = z/length
    """
    u = z / length
    stress_by_terms = []
    for exponent in range(_N_TERMS):
        for factor in (1.0, 1j) if exponent else (1.0,):
            f = factor * u**exponent
            f_of_conjugate = factor * u.conj() ** exponent
            derivative = factor * exponent * u ** max(exponent - 1, 0) / length
            normal_and_shear = f - f_of_conjugate + 2j * z.imag * derivative.conj()  # s_yy - i s_xy
            stress = [
                4 * f.real - normal_and_shear.real,
                normal_and_shear.real,
                -normal_and_shear.imag,
            ]
            stress_by_terms.append(np.stack(stress, axis=-1))
    return np.stack(stress_by_terms, axis=-1)


def fitted_size_effect(
    x: Array, y: Array, stress: Array, length: float, half_width: float
) -> SizeEffect:
    """Least-squares fit, by a power-series potential, of the stress that a body of finite size has
    beyond that of a half-plane, with the standard error of s_xx at the edges of contact.

    Parameters
    ----------
    x, y
        (n,) nodes, y <= 0 counted from the face
    stress
        (n, 3, m) stress of the elements minus that of the half-plane in m load cases: s_xx, s_yy,
        s_xy
    length
        unit of the potential's argument, and the distance up to which the fit holds [length]
    half_width
        half-width of the contact, with its middle at x = 0 [length]

    # notation: in subscripts of einsum i edges of contact, j and k terms of the series
    """
    # Least squares; `size_effect_basis` is the stress (n, 3, k) by each of k terms.
    matrix = size_effect_basis(x + 1j * y, length).reshape(3 * len(x), -1)
    right_side = stress.reshape(3 * len(x), -1)
    coefficients, _, rank, _ = np.linalg.lstsq(matrix, right_side, rcond=1e-10)

    # Standard error (m,) of s_xx at both edges, by the residual and the covariance; the larger one.
    residual = right_side - matrix @ coefficients
    standard_deviation = np.sqrt(np.sum(residual**2, axis=0) / max(len(matrix) - rank, 1))
    basis_at_edges = size_effect_basis(np.array([half_width + 0j, -half_width + 0j]), length)[:, 0]
    covariance = np.linalg.pinv(matrix.T @ matrix)
    variances = np.einsum("ij,jk,ik->i", basis_at_edges, covariance, basis_at_edges)
    return SizeEffect(
        length, np.asarray(coefficients), standard_deviation * np.sqrt(np.max(variances))
    )
