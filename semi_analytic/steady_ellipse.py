"""Steady ellipses of P and Q: their angles and loads, and permanent stick zone, W and W(x) of each
on any profile.

# notation: P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase), r = Q1/f, A = 2/E*; u and v amplitudes of
#           (Q -+ f P)/f; E largest Q - f P, G least Q + f P, I least Q - f P, J stick edge passes
#           G, M = E a turn later; P_T permanent stick load, P_c load at the stick edge, c = a(P_c);
#           P_x load at which a = |x|; w = +-Q - f P, which grows in slip

Every angle and load difference comes from r, P1 and the phase without cancellation, however small
the slip:

    u = |r exp(-i phase) - P1|,  v = |r exp(-i phase) + P1|,  P_T = P0 - (u + v)/2
    D = t_G - t_E = t_M - t_J = arg(P1^2 - r^2 + 2 i r P1 sin(phase)),  t_J - t_I = pi - D
    exp(-i t_E) = (r exp(-i phase) - P1)/u

    E-G  s = t - t_E:  rate f v sin(D - s)
                       P - P_c = u sin^2(s/2),         P_c - P_T = v sin^2((D - s)/2)
    I-J  s = t - t_I:  rate f u sin s,   P - P_c = 2 P1 sin t_E sin s
    J-M  s = t_M - t:  rate f u sin s
                       P - P_c = v sin^2((D + s)/2),   P_c - P_T = u sin^2(s/2)

    W    = (f A/pi) int w' Lam(P, P_c) dt,                 Lam = int_{P_c}^P ln(a(eta)/c) d eta
    W(x) = (f A/pi) int p(x, P) w' arccosh(|x|/c) dt       over the times with c < |x| < a(P)

The forward part is that of I-M, the reverse part that of E-G. Each phase is cut at the angles at
which P or P_c is the load P_b of a corner of the profile:

    P = P_b, cos t = (P_b - P0)/P1:   E-G  t_E + s = t
                                      I-J  t_E + s = t +- pi
                                      J-M  t_E - s = +-t
    P_c = P_b:                        E-G  v sin^2((D - s)/2) = P_b - P_T
                                      J-M  u sin^2(s/2) = P_b - P_T
                                      I-J  t_E - s = t +- pi

Between corners all three phases are smooth in s. Where P - P_c is no small share of P0, W is taken
apart into two courses of loads, P and P_c, by parts: w~ is w from the end of slip on, at G or M,
and L = ln a is all that is asked of the profile, a lookup in one table. Each course is cut at its
own corners, and intervals crowd to their lower loads: L is a smooth function of sqrt(P - P_b).

    W    = (f A/pi) [ -int w~ P' L(P) dt + int (w~ P_c' - w' (P - P_c)) L(P_c) dt ]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, legendre
from numpy.typing import NDArray

from scenes.array_types import Array
from scenes.chebyshev import SeriesAsPowers, piecewise_series_by_halving
from semi_analytic.hertz import log_excess
from semi_analytic.profiles import Contact, SymmetricContact
from semi_analytic.quadrature import GRADED_RULE, gauss_rule, graded_nodes

Indices = NDArray[np.intp]

PHASE_NAMES = ("E-G", "I-J", "J-M")
# Quadrature nodes that are evaluated at once: arrays of 128 kB and more get fresh memory at every
# call, which costs half as much again. Places x at once.
_INTERVAL_NODES_AT_ONCE = 16000
_POINTS_AT_ONCE = 500
# An interval has converged where every second node alone changes this share of W, which leaves
# 2e-14 or less (10 times as much where P hardly grows). After a few halvings this share of P0^2 is
# enough; an interval is halved so often at most.
_CONVERGED_SHARE_OF_GRADED_RULE = 1e-9
_FEW_HALVINGS = 3
_NEGLIGIBLE_CHECK_SHARE = 1e-14
_MOST_HALVINGS = 15


@dataclass(frozen=True, eq=False)
class Ellipses:
    """Steady ellipses, mirrored (Q -> -Q) where needed for 0 <= phase <= pi; all arrays of shape
    (m,).

    Attributes
    ----------
    mean_load, load_amplitude
        P0, P1
    forward_amplitude, reverse_amplitude
        u and v, the amplitudes of (Q - f P)/f and (Q + f P)/f, which grow in forward slip and
        fall in reverse slip
    cosine_of_start, sine_of_start
        of t_E, at which reverse slip begins
    slip_angle
        D, that of reverse slip, E to G
    permanent_stick_load
        P_T
    """

    mean_load: Array
    load_amplitude: Array
    forward_amplitude: Array
    reverse_amplitude: Array
    cosine_of_start: Array
    sine_of_start: Array
    slip_angle: Array
    permanent_stick_load: Array

    def take(self, members: Any) -> Ellipses:
        """The ellipses with the given numbers, a slice or a mask, as numpy selects `members`."""
        return Ellipses(**{name: values[members] for name, values in vars(self).items()})

    def divided_by(self, unit: Array) -> Ellipses:
        """The ellipses with every load divided by a unit of force per thickness, (m,)."""
        loads = {
            name: vars(self)[name] / unit
            for name in (
                "mean_load",
                "load_amplitude",
                "forward_amplitude",
                "reverse_amplitude",
                "permanent_stick_load",
            )
        }
        return replace(self, **loads)

    @property
    def slip_start(self) -> Array:
        """t_E in (0, pi]."""
        return np.arctan2(self.sine_of_start, self.cosine_of_start)

    @property
    def load_moves(self) -> NDArray[np.bool_]:
        """Whether P moves: an amplitude below 1e-200 of the mean moves no edge, and dividing by a
        subnormal one overflows.
        """
        return self.load_amplitude > 1e-200 * self.mean_load

    @property
    def slip_zone_load_scale(self) -> Array:
        """Size of the load P - P_c of the slip zones, by which methods are chosen, (m,) [force per
        thickness]: at most the largest P - P_c in the cycle, and at least half of it.

        It is the largest of u sin^2(D/2) and v sin^2(D/2), at the ends of the slip phases E-G and
        J-M, and of 2 P1 sin(t_E) sin(s) within I-J.

        # notation: u and v (`forward_amplitude`, `reverse_amplitude`) amplitudes of (Q -+ f P)/f; D
        #           (`slip_angle`) length of E-G and of J-M [rad]; P1 (`load_amplitude`) amplitude
        #           of P; `sine_of_start` sin(t_E); t_E angle t at which reverse slip begins; s
        #           angle in I-J, from 0 to pi - D; P_c load at the stick edge; f friction
        """
        tangent_of_half = np.tan(self.slip_angle / 2)
        squared_tangent_of_half = tangent_of_half * tangent_of_half
        slip_zone_load_at_phase_ends = (
            np.maximum(self.forward_amplitude, self.reverse_amplitude)
            * squared_tangent_of_half
            / (1 + squared_tangent_of_half)
        )
        # of sin(s): 1 if pi/2 lies in I-J, else sin(D)
        largest_sine = np.where(
            tangent_of_half > 1, 2 * tangent_of_half / (1 + squared_tangent_of_half), 1.0
        )
        return np.maximum(
            slip_zone_load_at_phase_ends,
            2 * self.load_amplitude * self.sine_of_start * largest_sine,
        )

    @property
    def largest_slip_zone_load(self) -> Array:
        """Largest load P - P_c of the slip zones in the cycle, (m,) [force per thickness]; P_c is
        the load at the stick edge.

        In the slip phase J-M it is v sin^2((D + s)/2), s from 0 to D. Its largest value is v inside
        the phase where D > pi/2 (Q1 > f P1), else v sin^2(D) at J. Elsewhere P - P_c is at most
        `slip_zone_load_scale`.

        # notation: v (`reverse_amplitude`) amplitude of (Q + f P)/f; D (`slip_angle`) length of J-M
        #           [rad]; s angle in J-M, counted back from its end; f friction
        """
        largest_sine = np.sin(np.minimum(self.slip_angle, math.pi / 2))
        largest_load_in_j_to_m = self.reverse_amplitude * largest_sine * largest_sine
        return np.maximum(self.slip_zone_load_scale, largest_load_in_j_to_m)

    def load_at_cosine(self, cosine: Array | float) -> Array:
        """P at the times t of given cos t, counted from the least load so that it keeps its digits
        close to full unloading.
        """
        return (self.mean_load - self.load_amplitude) + self.load_amplitude * (1 + cosine)


def ellipses_of(
    mean_load: Array,
    load_amplitude: Array,
    tangential_amplitude: Array,
    phase: Array,
    friction: Array,
) -> Ellipses:
    """Steady cycles of m elliptic load loops P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase): their
    loads, and the angles at which slip begins and ends.

    Among these are the amplitudes u, v of (Q -+ f P)/f and the load P_T of the permanent stick
    zone. Reverse slip begins at the time t_E and lasts through the angle D. Q0 does not change the
    steady state.

    Parameters
    ----------
    mean_load, load_amplitude, tangential_amplitude
        (m,) P0, P1 and Q1 [force per thickness]
    phase
        (m,) [rad]
    friction
        (m,) f > 0; the loops must not slide as a whole

    Examples
    --------

    >>> loop = ellipses_of(
    ...     *(np.array([value]) for value in (3.0, 1.0, 0.5, math.pi / 2, 0.5))
    ... )  # P0, P1, Q1, phase, f
    >>> loop.permanent_stick_load.round(12).tolist()  # u = v = sqrt 2: 3 - sqrt 2
    [1.585786437627]
    """
    # notation: r = Q1/f; r_cosine = r cos(phase) and r_sine = r |sin(phase)|, the amplitudes of the
    #           parts of Q/f in phase with P and a quarter of a cycle later
    r = tangential_amplitude / friction
    # cos and sin of the phase from the tangent of half of it; the mirrored loop, Q -> -Q, goes
    # round the other way: phase + pi.
    tangent_of_half = np.tan(phase / 2)
    r_times_squared_cosine_of_half = r / (1 + tangent_of_half * tangent_of_half)
    r_cosine = (
        np.where(tangent_of_half < 0, -1.0, 1.0)
        * r_times_squared_cosine_of_half
        * (1 - tangent_of_half)
        * (1 + tangent_of_half)
    )
    r_sine = 2 * r_times_squared_cosine_of_half * np.abs(tangent_of_half)
    u = np.hypot(r_cosine - load_amplitude, r_sine)
    v = np.hypot(r_cosine + load_amplitude, r_sine)
    nonzero_u = np.where(u > 0, u, 1.0)
    difference_of_squares = (load_amplitude - r) * (load_amplitude + r)
    return Ellipses(
        mean_load=mean_load,
        load_amplitude=load_amplitude,
        forward_amplitude=u,
        reverse_amplitude=v,
        cosine_of_start=(r_cosine - load_amplitude) / nonzero_u,
        sine_of_start=r_sine / nonzero_u,
        slip_angle=np.arctan2(2 * load_amplitude * r_sine, difference_of_squares),
        # P_T < 0 is gross sliding, and here only a round-off error.
        permanent_stick_load=np.maximum(mean_load - (u + v) / 2, 0.0),
    )


def rate_and_loads_in_phase(
    phase_name: str, ellipses: Ellipses, s: Array
) -> tuple[Array, Array, Array]:
    """Loads at angles `s` [rad] in one phase of slip of steady load ellipses: rate of w/f =
    (+-Q - f P)/f per rad, load P - P_c of the slip zones, and normal load P, shape of `s`.

        "E-G", reverse slip:  rate v sin(D - s),  P - P_c = u sin^2(s/2)
        "I-J", forward slip:  rate u sin(s),      P - P_c = 2 P1 sin(t_E) sin(s)
        "J-M", forward slip:  rate u sin(s),      P - P_c = v sin^2((D + s)/2)

    `phase_name` is one of these. s counts from the start of E-G and I-J, and back from the end of
    J-M. w grows in slip; P_c is the load at the stick edge.

    # notation: t_E (`slip_start`, `sine_of_start`) time at which E-G begins; u and v
    #           (`forward_amplitude`, `reverse_amplitude`) amplitudes of (Q -+ f P)/f; D
    #           (`slip_angle`) length of E-G and of J-M; P1 (`load_amplitude`) amplitude of P; f
    #           friction
    """
    # Tangents of half the angles stand for sines: numpy has them in vector code. `_sine_and_square`
    # of an angle is sin(angle) and sin^2(angle/2); `ellipses.load_at_cosine` is P from cos(t).
    if phase_name == "I-J":
        sine_in_rate, _ = _sine_and_square(s)
        _, squared_sine_of_half_time = _sine_and_square(ellipses.slip_start + s)
        return (
            ellipses.forward_amplitude * sine_in_rate,
            2 * ellipses.load_amplitude * ellipses.sine_of_start * sine_in_rate,
            ellipses.load_at_cosine(2 * squared_sine_of_half_time - 1),
        )
    if phase_name == "E-G":
        sine_in_rate, _ = _sine_and_square(ellipses.slip_angle - s)
        _, squared_sine_in_slip_zone_load = _sine_and_square(s)
        _, squared_sine_of_half_time = _sine_and_square(ellipses.slip_start + s)
        rate = ellipses.reverse_amplitude * sine_in_rate
        slip_zone_load = ellipses.forward_amplitude * squared_sine_in_slip_zone_load
    else:
        sine_in_rate, _ = _sine_and_square(s)
        _, squared_sine_in_slip_zone_load = _sine_and_square(ellipses.slip_angle + s)
        _, squared_sine_of_half_time = _sine_and_square(ellipses.slip_start - s)
        rate = ellipses.forward_amplitude * sine_in_rate
        slip_zone_load = ellipses.reverse_amplitude * squared_sine_in_slip_zone_load
    return rate, slip_zone_load, ellipses.load_at_cosine(1 - 2 * squared_sine_of_half_time)


def _sine_and_square(angle: Array) -> tuple[Array, Array]:
    """sin(angle) and sin^2(angle/2)."""
    tangent = np.tan(angle / 2)
    secant_square = 1 + tangent * tangent
    return 2 * tangent / secant_square, tangent * tangent / secant_square


def angle_of_squared_half_sine(squared_sine: Array) -> Array:
    """Angle [rad] whose half has the given sin^2, clipped to 0..1: 2 arcsin(sqrt(squared_sine))."""
    return 2 * np.arcsin(np.sqrt(np.clip(squared_sine, 0.0, 1.0)))


def _stick_edge_angles(ellipses: Ellipses, loads: Array) -> tuple[Array, Array]:
    """Angles [rad] at which the load P_c at the stick edge is one of `loads`, for the phases of
    slip E-G and J-M: 2 arcsin(sqrt((P_c - P_T)/v)) and 2 arcsin(sqrt((P_c - P_T)/u)).

    # notation: u and v (`forward_amplitude`, `reverse_amplitude`) amplitudes of (Q -+ f P)/f; P_T
    #           (`permanent_stick_load`) least load at the stick edge; f friction

    E-G is reverse slip, J-M the later part of forward slip. Both angles count back from the end of
    the phase. They are 0 for P_c below P_T, the load of the permanent stick zone, and pi for loads
    that the stick edge does not reach.
    """
    u = ellipses.forward_amplitude
    v = ellipses.reverse_amplitude
    load_above_permanent_stick = np.maximum(loads - ellipses.permanent_stick_load, 0.0)
    # 2 arcsin(sqrt(...)), clipped to [0, pi]
    angle_in_reverse_slip = angle_of_squared_half_sine(
        load_above_permanent_stick / np.where(v > 0, v, np.inf)
    )
    angle_in_late_forward_slip = angle_of_squared_half_sine(
        load_above_permanent_stick / np.where(u > 0, u, np.inf)
    )
    return angle_in_reverse_slip, angle_in_late_forward_slip


def cut_angles_of_phases(ellipses: Ellipses, corner_loads: Array) -> dict[str, Array]:
    """Angles [rad] in each slip phase between which its integrands are smooth, (cuts, m) ascending,
    by the name of the phase.

    "E-G" is reverse slip, "I-J" and then "J-M" forward slip. Angles count from the start of E-G and
    I-J, and back from the end of J-M. E-G begins at the time `slip_start` of P = P0 + P1 cos t; it
    is `slip_angle` long, as is J-M.

    Cuts are the ends of a phase, and where the edge of contact or of stick passes a corner of the
    profile. There P or P_c, the load at the stick edge, equals one of the loads `corner_loads`
    (c, 1). A corner that is not met adds a cut of no consequence. P0 and P1 are `mean_load` and
    `load_amplitude`; `load_moves` is False for constant P.
    """
    cosine_at_corner = (corner_loads - ellipses.mean_load) / np.where(
        ellipses.load_moves, ellipses.load_amplitude, np.inf
    )
    # t in [0, pi] at which P is the load of a corner, and pi minus it; a corner that is not met
    # gets a cut at the greatest or least load
    angle_at_corner = np.arccos(np.clip(cosine_at_corner, -1.0, 1.0))
    angle_from_least_load = np.arccos(np.clip(-cosine_at_corner, -1.0, 1.0))
    # angles at which P_c is that load, counted back from the end: in E-G and in J-M
    stick_edge_angle_in_reverse_slip, stick_edge_angle_in_late_forward_slip = _stick_edge_angles(
        ellipses, corner_loads
    )
    start_of_reverse_slip = ellipses.slip_start
    full_turn = 2 * math.pi
    # where P is the load of a corner (twice in each phase), then where P_c is (once, twice in I-J)
    inner_cuts = {
        "E-G": (
            angle_at_corner - start_of_reverse_slip,
            full_turn - angle_at_corner - start_of_reverse_slip,
            ellipses.slip_angle - stick_edge_angle_in_reverse_slip,
        ),
        "I-J": (
            angle_from_least_load - start_of_reverse_slip,
            full_turn - angle_from_least_load - start_of_reverse_slip,
            start_of_reverse_slip - angle_from_least_load,
            start_of_reverse_slip + angle_from_least_load,
        ),
        "J-M": (
            start_of_reverse_slip - angle_at_corner,
            start_of_reverse_slip + angle_at_corner,
            stick_edge_angle_in_late_forward_slip,
        ),
    }
    length_of_phase = {
        "E-G": ellipses.slip_angle,
        "I-J": math.pi - ellipses.slip_angle,
        "J-M": ellipses.slip_angle,
    }
    cut_angles_by_phase = {}
    for phase_name, length in length_of_phase.items():
        cut_angles = np.concatenate(
            [np.zeros_like(start_of_reverse_slip)[None], *inner_cuts[phase_name], length[None]]
        )
        cut_angles_by_phase[phase_name] = np.sort(
            np.clip(cut_angles, cut_angles[0], cut_angles[-1]), axis=0
        )
    return cut_angles_by_phase


def quadrature_error(integrals_by_stride: Array, integral_size: Array) -> Array:
    """Upper bound of the quadrature error of integrals, (m,), as share of their size.

    `integrals_by_stride` (3, m) are the integrals by all nodes of one rule, by every second, by
    every fourth. d is the difference of the first two, e that of the last two, as shares of
    `integral_size`. The error is d. It is d^1.5 where d <= e^1.5: differences fall exponentially,
    as for smooth integrands, for which theory has d^2.
    """
    positive_size = np.where(integral_size > 0, integral_size, 1.0)
    integral_by_all, integral_by_every_second, integral_by_every_fourth = integrals_by_stride
    # The limit keeps the power finite where `integral_size` is as tiny as 1e-265.
    relative_difference = np.minimum(
        np.abs(integral_by_all - integral_by_every_second) / positive_size, 1e100
    )
    coarser_relative_difference = np.minimum(
        np.abs(integral_by_every_second - integral_by_every_fourth) / positive_size, 1e100
    )
    return np.where(
        relative_difference <= coarser_relative_difference**1.5,
        relative_difference**1.5,
        relative_difference,
    )


def work_density_of(
    ellipses: Ellipses, contact: Contact, x: Array, node_stride: int = 1
) -> tuple[Array, Array]:
    """Friction work per area W(x) of a cycle of each load ellipse, at one place |x| for each: in
    forward slip and in reverse slip, (m,) each.

    Both are times pi E*/(2 f^2) [stress * force per thickness]. `ellipses` holds the loads and
    angles of m ellipses, `contact` is the normal contact P(a) of the profile. With `node_stride` =
    2 every second node of the quadrature rule is taken, which is right to some 1e-6. E* is the
    composite modulus, f the friction.
    """
    # rows: the slip phases E-G (reverse), I-J and J-M (forward)
    densities_of_phases = np.zeros((len(PHASE_NAMES), len(x)))
    # _POINTS_AT_ONCE: 500
    for first_point_number in range(0, len(x), _POINTS_AT_ONCE):
        point_numbers = np.arange(
            first_point_number, min(first_point_number + _POINTS_AT_ONCE, len(x))
        )
        densities_of_phases[:, point_numbers] = _work_density_of_phases(
            ellipses.take(point_numbers[:, None]), contact, x[point_numbers, None], node_stride
        )
    return densities_of_phases[1] + densities_of_phases[2], densities_of_phases[0]


def _work_density_of_phases(
    ellipses: Ellipses, contact: Contact, x: Array, node_stride: int
) -> Array:
    """Friction work per area W(x) in each phase of slip of m load ellipses, times pi E*/(2 f^2),
    (3, m), at one |x| for each: the integral of p w'/f arccosh(|x|/c) over the time, an angle
    [rad] of the ellipse.

    w = +-Q - f P grows in slip, and (A/pi) w' arccosh(|x|/c) is the slip rate at x; c is the
    half-width of stick, A = 2/E*. The phases are E-G (reverse slip), I-J and J-M (forward slip).
    `contact` gives P(a), p(x, P) and arccosh(|x|/c). `ellipses` and `x` are columns (m, 1);
    `node_stride` 2 takes every second node of the quadrature rule. E* is the composite modulus, f
    the friction.
    """
    # P_x, under which the edge of contact is at x
    load_at_x = contact.load(x)
    # (number of the phase, first and last angle at which the point slips), four of them
    ranges_of_slip = _ranges_of_slip(ellipses, load_at_x)
    # angles between which the integrands are smooth, (cuts, m) for each phase
    cut_angles_by_phase = list(
        cut_angles_of_phases(
            ellipses.take((slice(None), 0)), contact.corner_loads[:, None]
        ).values()
    )
    density_of_phases = np.zeros((len(PHASE_NAMES), len(x)))
    for phase_number, first_angle, last_angle in ranges_of_slip:
        # intervals of the range of slip, between cuts, of every ellipse
        inner_cut_angles = np.clip(
            cut_angles_by_phase[phase_number].T, first_angle, np.maximum(first_angle, last_angle)
        )
        cut_angles = np.concatenate([first_angle, inner_cut_angles, last_angle], axis=1)
        ellipse_number, cut_number = np.nonzero(cut_angles[:, 1:] > cut_angles[:, :-1])
        if not len(ellipse_number):
            continue

        # graded to singular ends: angles and weights, (intervals, nodes)
        angle_in_phase, node_weights = graded_nodes(
            cut_angles[ellipse_number, cut_number],
            cut_angles[ellipse_number, cut_number + 1],
            node_stride,
        )
        weighted_density_at_nodes = _weighted_work_rate_at_points(
            rate_and_loads_in_phase(
                PHASE_NAMES[phase_number], ellipses.take(ellipse_number), angle_in_phase
            ),
            node_weights,
            contact,
            x[ellipse_number],
            load_at_x[ellipse_number],
        )
        # add the intervals of each ellipse
        np.add.at(
            density_of_phases[phase_number],
            ellipse_number,
            np.sum(weighted_density_at_nodes, axis=1),
        )
    return density_of_phases


def _weighted_work_rate_at_points(
    rate_and_loads: tuple[Array, Array, Array],
    weights: Array,
    contact: Contact,
    x: Array,
    load_at_x: Array,
) -> Array:
    """Friction work per area and rad at points x times quadrature weights, (n, nodes): weight *
    w'/f p(x, P) arccosh(|x|/c), which is W(x) pi E*/(2 f^2) when summed over the nodes.

    w = +-Q - f P grows in slip; c is the half-width of stick, P_c the load at which the contact
    would end there. E* is the composite modulus, f the friction.

    Parameters
    ----------
    rate_and_loads
        w'/f, P - P_c and P at the nodes, (n, nodes) each
    weights
        (n, nodes) of a quadrature rule over the angle [rad]
    contact
        the normal contact of the profile
    x, load_at_x
        (n, 1) place |x|, and the load under which the edge of contact is there
    """
    rate, slip_zone_load, load = rate_and_loads
    stick_edge_load = np.maximum(load - slip_zone_load, 0.0)
    # P_x - P_c
    load_outside_stick = np.maximum(load_at_x - stick_edge_load, 0.0)
    # of the stick edge beyond the least half-width
    stick_edge_advance = contact.edge_advance(stick_edge_load)
    arccosh_ratio = contact.arccosh_ratio(x, load_outside_stick, stick_edge_advance)
    return weights * rate * contact.pressure(x, load) * arccosh_ratio


def _ranges_of_slip(ellipses: Ellipses, load_at_x: Array) -> tuple[tuple[int, Array, Array], ...]:
    """Angles [rad] between which a point x slips in the cycle of each load ellipse, four ranges:
    number of the slip phase, first and last angle s in the phase, (m, 1) each.

    The point slips while it is in contact and the stick edge is nearer to the centre. A range whose
    last angle is below the first is empty. The phases are E-G, reverse slip (0), and I-J, J-M,
    forward slip (1, 2). E-G comes twice, before and after the least load, at which the point may be
    open.

    The point is open for angles up to h on either side of the least load P_min, at t = pi: 2 P1
    sin^2(h/2) = P_x - P_min. `load_at_x` (m, 1) is P_x, under which the edge of contact is at x.
    The stick edge passes the point

        in E-G where  sin^2((D - s)/2) = (P_x - P_T)/v
        in I-J at     s = t_E - h
        in J-M where  sin^2(s/2) = (P_x - P_T)/u

    # notation: P = P0 + P1 cos t, with `mean_load` P0 and `load_amplitude` P1 (`load_moves`: not
    #           0); P_T least load at the stick edge; u, v amplitudes of (Q -+ f P)/f; t_E
    #           (`slip_start`) time of E, D (`slip_angle`) angle from E to G; s counts from the
    #           start of E-G and I-J, and back from the end of J-M; f friction
    """
    share_of_load_range = (load_at_x - ellipses.mean_load + ellipses.load_amplitude) / np.where(
        ellipses.load_moves, 2 * ellipses.load_amplitude, 1.0
    )
    # At constant P the point is open throughout or never.
    share_at_constant_load = np.where(load_at_x > ellipses.mean_load, 1.0, 0.0)
    # h = 2 arcsin(sqrt(share))
    open_angle = angle_of_squared_half_sine(
        np.where(ellipses.load_moves, share_of_load_range, share_at_constant_load)
    )
    start_of_reverse_slip = ellipses.slip_start
    length_of_reverse_slip = ellipses.slip_angle
    # angles at which the stick edge is at x, counted back from the end: in E-G and in J-M
    stick_edge_angle_in_reverse_slip, stick_edge_angle_in_late_forward_slip = _stick_edge_angles(
        ellipses, load_at_x
    )
    # that of E-G, counted from the start of E-G
    start_of_slip_at_x = np.maximum(length_of_reverse_slip - stick_edge_angle_in_reverse_slip, 0.0)
    end_of_slip_at_x = np.minimum(length_of_reverse_slip, stick_edge_angle_in_late_forward_slip)
    # angles at which the point opens before the least load, and closes after it; counted back in
    # J-M
    opening_in_reverse_slip = math.pi - open_angle - start_of_reverse_slip
    closing_in_reverse_slip = math.pi + open_angle - start_of_reverse_slip
    opening_in_early_forward_slip = 2 * math.pi - open_angle - start_of_reverse_slip
    opening_in_late_forward_slip = start_of_reverse_slip - math.pi + open_angle
    closing_in_late_forward_slip = start_of_reverse_slip + math.pi - open_angle
    # E-G (0) before and after the least load, I-J (1), J-M (2)
    return (
        (0, start_of_slip_at_x, np.minimum(length_of_reverse_slip, opening_in_reverse_slip)),
        (0, np.maximum(start_of_slip_at_x, closing_in_reverse_slip), length_of_reverse_slip),
        (
            1,
            np.abs(start_of_reverse_slip - open_angle),
            np.minimum(math.pi - length_of_reverse_slip, opening_in_early_forward_slip),
        ),
        (
            2,
            np.maximum(0.0, opening_in_late_forward_slip),
            np.minimum(end_of_slip_at_x, closing_in_late_forward_slip),
        ),
    )


BufferedKernel = Callable[[Array, Array, Array], Array]
"""A multiple of Lam = int ln(a(eta)/a(P_c)) d eta over P_c < eta < P, from P_c, P - P_c and an
array for intermediate values, (phases, n, m) each; may overwrite all but P - P_c.
"""

_LEAST_DIVISOR = 1e-100
_LEAST_SHARE_OF_MEAN_LOAD = 1e-200


# ---------------------------------------------- any profile: intervals of phases, and series of Lam


class IntervalRule(NamedTuple):
    """Quadrature rule on [0, 1], whose nodes are held as signed distances from an end.

    Attributes
    ----------
    signed_distance
        (n, 1) of each node, negative from the upper end
    is_from_lower_end
        whether that end is 0, (n, 1) or one for all
    weight
        (n,)
    check_weights
        (k, n) weights of the k error checks: sums that are 0 but for the error of the rule
    """

    signed_distance: Array
    is_from_lower_end: NDArray[np.bool_]
    weight: Array
    check_weights: Array


def _graded_interval_rule() -> IntervalRule:
    """The graded quadrature rule on [0, 1], for integrands singular at the ends, with its error
    check: the rule minus that of every second node alone, with weights doubled. So the weights of
    the check are -w and w in turn; the sum over an integrand is 0 but for the error.
    """
    # GRADED_RULE holds the nodes as distances from both ends
    weights = graded_nodes(0.0, 1.0)[1]
    check_weights = weights.copy()
    check_weights[::2] -= 2 * weights[::2]
    is_in_lower_half = GRADED_RULE.distance_from_begin[:, None] < 0.5
    # from the nearer end of [0, 1], negative from the upper one
    signed_distance = np.where(
        is_in_lower_half,
        GRADED_RULE.distance_from_begin[:, None],
        -GRADED_RULE.distance_from_end[:, None],
    )
    return IntervalRule(signed_distance, is_in_lower_half, weights, check_weights[None])


def _legendre_interval_rule(n_nodes: int, n_crowded_ends: int) -> IntervalRule:
    """Gauss' rule of `n_nodes` nodes on [0, 1] for integrands with square roots at the ends: nodes
    as signed distances from an end, weights, and error checks.

    The error checks are the last three Legendre coefficients of the integrand, which are small
    where it is resolved. A change of variable makes square roots smooth and crowds the nodes t: t^2
    to the lower end (`n_crowded_ends` = 1), 3 t^2 - 2 t^3 to both (2), none (0).
    """
    # nodes and weights (n_nodes,) on [0, 1]
    nodes, weights = gauss_rule(n_nodes)
    # the last three Legendre polynomials at the nodes, (3, n_nodes), times 2 k + 1 for the order k
    orders = np.arange(n_nodes - 3, n_nodes)
    polynomials = legendre.legvander(2 * nodes - 1, n_nodes - 1)[:, orders].T
    weights_of_coefficients = polynomials * (2 * orders[:, None] + 1)
    if n_crowded_ends == 0:
        signed_distance = nodes[:, None]
        is_from_lower_end = np.array(True)
    elif n_crowded_ends == 1:
        weights = weights * 2 * nodes
        signed_distance = nodes[:, None] ** 2
        is_from_lower_end = np.array(True)
    else:
        weights = weights * 6 * nodes * (1 - nodes)
        node_from_nearer_end = np.minimum(nodes, 1 - nodes)
        crowded_distance = (
            node_from_nearer_end * node_from_nearer_end * (3 - 2 * node_from_nearer_end)
        )[:, None]
        is_from_lower_end = nodes[:, None] < 0.5
        signed_distance = np.where(is_from_lower_end, crowded_distance, -crowded_distance)
    # distances, whether they count from the lower end, weights of the rule and of its error checks
    return IntervalRule(
        signed_distance, is_from_lower_end, weights, weights * weights_of_coefficients
    )


# For all that is singular; for intervals of slip phases without corners, and for others; for those
# of one course of a load, by length up to these [rad].
_GRADED_RULES = (_graded_interval_rule(),)
_PHASE_RULES = (_legendre_interval_rule(20, 0), _legendre_interval_rule(24, 2))
_COURSE_RULES = tuple(_legendre_interval_rule(n_nodes, 1) for n_nodes in (8, 10, 12, 16, 24))
_COURSE_RULE_LENGTHS = np.array([0.1, 0.3, 0.6, 1.0])
# The share of W below which the three last coefficients have converged: they fall like a power
# where two corners are close, and leave 1e-3 of themselves. In courses of loads the share is one of
# 50 P0^2 where W is less: that leaves 2e-12 of P0^2 where P hardly grows, 1e-14 elsewhere.
_CONVERGED_COEFFICIENT_SHARE = 3e-8
_LEAST_WORK_OVER_SQUARED_LOAD = 50.0
# Error of an integral over its largest error check, at most: where the interval has converged, and
# where W is too small for that.
_ERROR_OVER_SMALL_CHECK = 1e-2
_ERROR_OVER_LARGE_CHECK = 4.0
# Shares of P0 down to which Lam is taken from L = ln a at P and at P_c, and from L between them:
# they keep 1e-10 of Lam.
_DEEP_SLIP_SHARE = 0.002
_SHALLOW_SLIP_SHARE = 1e-6
# Fewer ellipses than these take one rule, and so few no table of ln a.
_FEW_ELLIPSES = 100
_ELLIPSES_WITHOUT_TABLE = 8

Kernel = Callable[[Array, Array], Array]
"""Lam from P and P - P_c, (nodes, intervals) each."""


class AngleIntervals(NamedTuple):
    """Intervals of angle [rad] over which the work of ellipses is integrated, sorted by group.

    A group is a phase of slip, or a course: one load, P or P_c, through a phase.

    Attributes
    ----------
    group_number
        (n,) number of the group
    ellipse_number
        (n,) number of the ellipse
    begin_angle, end_angle
        (n,) ends of the interval [rad]
    rule_number
        (n,) number of the quadrature rule
    """

    group_number: Indices
    ellipse_number: Indices
    begin_angle: Array
    end_angle: Array
    rule_number: Indices

    @classmethod
    def of_group(
        cls,
        group_number: int,
        ellipse_number: Indices,
        begin_angle: Array,
        end_angle: Array,
        rule_number: Indices,
    ) -> AngleIntervals:
        """Intervals from `begin_angle` to `end_angle` [rad], (n,) each, all of one group, a phase
        of slip or a load through it; with the numbers of their ellipses and quadrature rules, (n,).
        """
        return cls(
            np.full(len(ellipse_number), group_number),
            ellipse_number,
            begin_angle,
            end_angle,
            rule_number,
        )

    @classmethod
    def joined(cls, parts: Sequence[AngleIntervals]) -> AngleIntervals:
        """The intervals of all `parts`, one after the other."""
        return cls._make(np.concatenate(column) for column in zip(*parts, strict=True))

    def take(self, numbers: Indices | NDArray[np.bool_]) -> AngleIntervals:
        """The intervals of the given numbers, or of a mask."""
        return AngleIntervals._make(column[numbers] for column in self)

    def halved(self) -> AngleIntervals:
        """Both halves of each interval, side by side so that groups stay in order."""
        middle_angle = (self.begin_angle + self.end_angle) / 2
        return AngleIntervals(
            group_number=np.repeat(self.group_number, 2),
            ellipse_number=np.repeat(self.ellipse_number, 2),
            begin_angle=np.ravel([self.begin_angle, middle_angle], order="F"),
            end_angle=np.ravel([middle_angle, self.end_angle], order="F"),
            rule_number=np.repeat(self.rule_number, 2),
        )


# Relative error of W by the phase integrals, of the last digits of loads and angles, and of Lam by
# series.
_RELATIVE_ERROR_OF_PHASE_INTEGRALS = 2e-12
_LAST_DIGIT_SHARE = 1e-15
_LAM_ERROR_OF_SERIES = 1e-13
# Last digits of a loop in W: a power of three of its amplitudes, and as much for their angles.
_LAST_DIGITS_OF_LOOP = 6.0
# Of W: what the rules leave out that are picked by where Lam is singular; at most 1.7e-11 in 36,000
# random loops.
_RELATIVE_ERROR_OF_LAM_RULES = 5e-11


def roundoff_error(ellipses: Ellipses, work: Array) -> Array:
    """Upper bound of the round-off error of the friction work W of a cycle, by the last digits of
    loads and angles, (m,). `work` is W pi E*/(2 f^2) [force^2 per thickness^2], as is the error.

    # notation: u and v (`forward_amplitude`, `reverse_amplitude`) amplitudes of (Q -+ f P)/f; D
    #           (`slip_angle`) length of the phases E-G and J-M [rad], pi - D of I-J; P1, Q1
    #           amplitudes of P and Q; E* composite modulus

    u and v are differences of Q1/f and P1. Digits are lost where u or v is small against the loads,
    or D or pi - D against pi. The relative error is 2e-12 plus 1e-15, a last digit, times the loads
    over u or v and pi over D or pi - D. A last digit of the loads, squared, is added.
    """
    # P1 + (u + v)/2
    loop_size = (
        ellipses.load_amplitude + (ellipses.forward_amplitude + ellipses.reverse_amplitude) / 2
    )
    smaller_amplitude = np.minimum(ellipses.forward_amplitude, ellipses.reverse_amplitude)
    shortest_phase = np.minimum(ellipses.slip_angle, math.pi - ellipses.slip_angle)
    # Nothing slips where one of them is 0; _LEAST_DIVISOR is 1e-100.
    amplification_by_amplitudes = loop_size / np.where(
        smaller_amplitude > _LEAST_DIVISOR * loop_size, smaller_amplitude, np.inf
    )
    amplification_by_angles = math.pi / np.where(
        shortest_phase > _LEAST_DIVISOR, shortest_phase, np.inf
    )
    # Where a difference has no digit left W may be anything up to the square of a last digit.
    last_digit_of_loads = _LAST_DIGIT_SHARE * loop_size
    # _RELATIVE_ERROR_OF_PHASE_INTEGRALS: 2e-12; _LAST_DIGIT_SHARE: 1e-15
    relative_error = _RELATIVE_ERROR_OF_PHASE_INTEGRALS + _LAST_DIGIT_SHARE * (
        amplification_by_amplitudes + amplification_by_angles
    )
    return relative_error * np.abs(work) + last_digit_of_loads * last_digit_of_loads


def error_by_digits_of_loads(ellipses: Ellipses) -> Array:
    """Upper bound of the relative error of the friction work W of each load loop, (m,), by the last
    digits of its loads and phase alone.

    # notation: P1 (`load_amplitude`), Q1 amplitudes of P and Q, r = Q1/f; t_E the time at which
    #           reverse slip begins, u cos(t_E) = r cos(phase) - P1; `cosine_of_start`,
    #           `sine_of_start` of t_E

    W goes as a power of the amplitudes u and v of (Q -+ f P)/f; its exponent is 3 for small slip. u
    is the difference of Q1/f and P1 where the loads are nearly in phase. Where the phase is near
    pi, sin(phase) has only the digits of pi - phase. u and v are `forward_amplitude` and
    `reverse_amplitude`.
    """
    loop_size = (
        ellipses.load_amplitude + (ellipses.forward_amplitude + ellipses.reverse_amplitude) / 2
    )
    smaller_amplitude = np.minimum(ellipses.forward_amplitude, ellipses.reverse_amplitude)
    r_sine = ellipses.forward_amplitude * ellipses.sine_of_start  # r |sin(phase)|
    # r cos(phase)
    r_cosine = ellipses.forward_amplitude * ellipses.cosine_of_start + ellipses.load_amplitude
    # minus the cotangent; _LEAST_DIVISOR is 1e-100
    cotangent_of_phase = -r_cosine / np.where(r_sine > _LEAST_DIVISOR * loop_size, r_sine, np.inf)
    amplification_by_phase = np.where(r_cosine < 0, cotangent_of_phase, 0.0)
    amplification_by_amplitudes = loop_size / np.where(
        smaller_amplitude > _LEAST_DIVISOR * loop_size, smaller_amplitude, np.inf
    )
    # six last digits, of 1e-15 each
    return (
        _LAST_DIGITS_OF_LOOP
        * _LAST_DIGIT_SHARE
        * (1 + amplification_by_amplitudes + math.pi * amplification_by_phase)
    )


def works_over_time(ellipses: Ellipses, contact: Contact) -> tuple[Array, Array]:
    """Friction work W of forward and of reverse slip per steady cycle of each load ellipse, times
    pi E*/(2 f^2), (m,) each [force^2 per thickness^2]. All digits count even where almost nothing
    slips; takes 1 ms and more each.

    W is an integral over the time of slip, cut where an edge passes a corner of the profile. Next
    to singular ends the rule is graded. Intervals that have not converged are halved; W is NaN
    where that does not help. The integrand is w'/f times the kernel Lam(P, P_c), w = +-Q - f P.
    Lam is the integral of ln(a/a(P_c)) over the loads from P_c, that at the stick edge, to P; a is
    the contact half-width. `contact` is the normal contact P(a) of the profile.

    At constant P and Q between -k f P and k f P the sum is 2 P^2 [(1 - k) ln(1 - k) + k - k^2/2].
    E* is the composite modulus, f the friction.

    >>> from semi_analytic.hertz import HertzContact
    >>> loop = ellipses_of(
    ...     *(np.array([value]) for value in (1.0, 0.0, 0.3, math.pi / 2, 0.5))
    ... )  # k = 0.6
    >>> forward_work, reverse_work = works_over_time(
    ...     loop, HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    ... )
    >>> (
    ...     round(float(forward_work[0] + reverse_work[0]), 12),
    ...     round(2 * (0.4 * math.log(0.4) + 0.6 - 0.18), 12),
    ... )
    (0.106967414501, 0.106967414501)
    """
    # the last value is the error; _GRADED_RULES: the rule for singular ends alone;
    # _CONVERGED_SHARE_OF_GRADED_RULE: 1e-9
    forward_work, reverse_work, _ = _work_over_phases(
        ellipses,
        contact,
        contact.dissipation_kernel,
        _GRADED_RULES,
        _CONVERGED_SHARE_OF_GRADED_RULE,
    )
    return forward_work, reverse_work


# Share of the mean load below which a load at the stick edge is taken for that share: W changes by
# 1e-13 of A f^2 P0^2. Octaves by which tables of ln a differ, so that the next block or call finds
# its own.
LEAST_LOAD_SHARE = 2.0**-48
_OCTAVES_OF_TABLE_STEP = 8
# Nothing that rounds differently leaves a table.
_ROUNDING_MARGIN = 1e-12


def groups_by_largest_load(ellipses: Ellipses) -> Iterator[tuple[Indices, int, int]]:
    """Groups of ellipses whose loads one table of ln a(P) can serve, a(P) the contact half-width:
    numbers of the ellipses, first and last octave of the table.

    Loads of a group lie in [2^first octave, 2^(last octave + 1)), its largest ones within eight
    octaves. The group of an ellipse follows from its own loads alone. Loads below 2^-48 of the mean
    (LEAST_LOAD_SHARE) count as that. `permanent_stick_load` is the least load at the stick
    edge, the least that an ellipse looks up.
    """
    # _ROUNDING_MARGIN: 1e-12
    largest_load = (ellipses.mean_load + ellipses.load_amplitude) * (1 + _ROUNDING_MARGIN)
    least_load = np.maximum(
        ellipses.permanent_stick_load, LEAST_LOAD_SHARE * ellipses.mean_load
    ) * (1 - _ROUNDING_MARGIN)
    # a step is eight octaves; the octaves of a table are whole steps
    step_of_largest_load = (np.frexp(largest_load)[1] - 1) // _OCTAVES_OF_TABLE_STEP
    step_of_least_load = (np.frexp(least_load)[1] - 1) // _OCTAVES_OF_TABLE_STEP
    for last_step in np.unique(step_of_largest_load).tolist():
        ellipse_numbers = np.flatnonzero(step_of_largest_load == last_step)
        first_step = int(np.min(step_of_least_load[ellipse_numbers]))
        first_octave = first_step * _OCTAVES_OF_TABLE_STEP
        last_octave = (last_step + 1) * _OCTAVES_OF_TABLE_STEP - 1
        yield ellipse_numbers, first_octave, last_octave


def dissipation_of(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """Friction work W of forward and of reverse slip per steady cycle of each load ellipse, times
    pi E*/(2 f^2), (2, m) [force^2 per thickness^2], for any profile.

    Right to ten digits; NaN where the quadrature does not converge. `ellipses` holds the loads and
    angles of m ellipses, `contact` is the normal contact P(a) of the profile. Where the load of the
    slip zones is no small share of the mean of P, ln a(P) is looked up in a series, a(P) the
    contact half-width. E* is the composite modulus, f the friction.

    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.steady_ellipse import ellipses_of
    >>> loop = ellipses_of(
    ...     *(np.array([value]) for value in (1.0, 0.0, 0.3, math.pi / 2, 0.5))
    ... )  # constant P, |Q| <= 0.6 f P
    >>> works = dissipation_of(loop, HertzContact(modulus=1.0, radius=1.0, datum_length=1.0))
    >>> (
    ...     round(float(works.sum()), 9),
    ...     round(2 * (0.4 * math.log(0.4) + 0.6 - 0.18), 9),
    ... )  # theory, constant load
    (0.106967415, 0.106967415)
    """
    return dissipation_and_error(ellipses, contact)[:2]


def dissipation_and_error(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """Friction work of forward and of reverse slip in a steady cycle, and an upper bound of the
    error of their sum, for any profile, (3, m).

    All are times pi E*/(2 f^2) [force^2 per thickness^2]. NaN where the quadrature does not
    converge. `contact` is the normal contact P(a) of the profile, `relative_roundoff` the relative
    error of P(a). E* is the composite modulus, f the friction.
    """
    # rows: forward work, reverse work, error of their sum
    works_and_error = np.empty((3, len(ellipses.mean_load)))
    # octaves: powers of two between which the loads of the group lie
    for ellipse_numbers, first_octave, last_octave in groups_by_largest_load(ellipses):
        works_and_error[:, ellipse_numbers] = _dissipation_of_group(
            ellipses.take(ellipse_numbers), contact, first_octave, last_octave
        )
    total_work = works_and_error[0] + works_and_error[1]
    # round-off of the loads and angles, and of P(a) itself
    works_and_error[2] += roundoff_error(ellipses, total_work) + contact.relative_roundoff * np.abs(
        total_work
    )
    return works_and_error


def _dissipation_of_group(
    ellipses: Ellipses, contact: SymmetricContact, first_octave: int, last_octave: int
) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), and an upper bound of the
    error of their sum, (3, m).

    The method follows from how deep the slip zones are: `slip_zone_load_scale`, the largest P - P_c
    to a factor of two, over the mean load P0:

    - above 0.002, integrals over the loads P and P_c;
    - above 1e-6, the kernel Lam = int ln(a(eta)/a(P_c)) d eta by a table of ln a;
    - below, and up to 0.002 for eight ellipses or fewer, Lam of the normal contact itself, slow but
      with all digits.

    P_c is the load at the stick edge, a the contact half-width. Loads of the ellipses lie from
    2^`first_octave` to 2^(`last_octave` + 1). The last arguments of `_work_over_phases` are
    quadrature rules and 3e-8, the share of W below which error checks count as converged. E* is the
    composite modulus, f the friction.
    """
    works_and_error = np.empty((3, len(ellipses.mean_load)))

    # choose the method of each ellipse
    slip_zone_share = ellipses.slip_zone_load_scale / ellipses.mean_load
    # _DEEP_SLIP_SHARE: 0.002
    has_deep_slip = slip_zone_share > _DEEP_SLIP_SHARE
    uses_table = np.zeros(len(slip_zone_share), dtype=bool)
    # loads at which integrals over loads are cut, first those of the corners of the profile, and
    # the function ln a(P)
    cut_loads = contact.corner_loads
    log_half_width = _log_half_width_of(contact)
    # _SHALLOW_SLIP_SHARE: 1e-6; _ELLIPSES_WITHOUT_TABLE: 8
    log_table = None
    if len(ellipses.mean_load) > _ELLIPSES_WITHOUT_TABLE and np.any(
        slip_zone_share > _SHALLOW_SLIP_SHARE
    ):
        # polynomials of ln a; integrals are cut at the ends of each, `series_ends`
        log_table = _cached_log_half_width(contact, first_octave, last_octave + 1)
        cut_loads = log_table.series_ends
        log_half_width = log_table
        uses_table = (slip_zone_share > _SHALLOW_SLIP_SHARE) & ~has_deep_slip
    uses_contact = ~has_deep_slip & ~uses_table

    # Lam of the contact
    if np.any(uses_contact):
        works_and_error[:, uses_contact] = _work_over_phases(
            ellipses.take(uses_contact),
            contact,
            contact.dissipation_kernel,
            _PHASE_RULES,
            _CONVERGED_COEFFICIENT_SHARE,
        )

    # Lam by the table of ln a
    if log_table is not None and np.any(uses_table):
        works_and_error[:, uses_table] = _work_by_table(
            ellipses.take(uses_table), contact, log_table, slip_zone_share[uses_table]
        )
    # no kernel: integrals of ln a over the loads
    if np.any(has_deep_slip):
        works_and_error[:, has_deep_slip] = _work_over_loads(
            ellipses.take(has_deep_slip), cut_loads, log_half_width
        )
    return works_and_error


def _work_by_table(
    ellipses: Ellipses, contact: SymmetricContact, log_table: LogHalfWidth, slip_zone_share: Array
) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), and an upper bound of the
    error of their sum, (3, m), from a table of ln a.

    The kernel of the work is Lam = int ln(a(eta)/a(P_c)) d eta over the loads from P_c to P. a is
    the contact half-width, P_c the load at the stick edge. `slip_zone_share` (m,) is the largest P
    - P_c over the mean load, to a factor of two. Lam by the series of the `log_table` has the last
    digits of P - P_c times the slope of ln a, not of itself: that error is added. E* is the
    composite modulus, f the friction.
    """
    # _PHASE_RULES: Gauss' rules of 20 and 24 nodes; _CONVERGED_COEFFICIENT_SHARE: 3e-8 of W
    works_and_error = _work_over_phases(
        ellipses,
        contact,
        log_table.dissipation_kernel_by_series,
        _PHASE_RULES,
        _CONVERGED_COEFFICIENT_SHARE,
    )
    forward_work, reverse_work, error_of_work = works_and_error
    work = np.abs(forward_work + reverse_work)
    # in place, so that it counts in `works_and_error`; _LAM_ERROR_OF_SERIES: 1e-13
    error_of_work += _LAM_ERROR_OF_SERIES / slip_zone_share * work
    return works_and_error


def _work_over_phases(
    ellipses: Ellipses,
    contact: Contact,
    kernel: Kernel,
    rules: tuple[IntervalRule, ...],
    converged_share: float,
) -> Array:
    """Friction work W of forward and of reverse slip of m steady ellipses of loads P and Q, and the
    error of their sum, (3, m), by integrals over time. All are times pi E*/(2 f^2).

    The integrand in each phase of slip is l'/f Lam, with Lam = int ln(a(eta)/a(P_c)) d eta from P_c
    to P, which is `kernel`(P, P - P_c). The level l is Q - f P in forward slip and -Q - f P in
    reverse slip. It grows there at the rate l'. P_c is the load at the stick edge, a the contact
    half-width. Phases are cut where an edge passes a corner of the profile. Each interval is
    integrated by one of the quadrature `rules`, weights at nodes, and halved until its error check
    is below `converged_share` of W. E* is the composite modulus, f the friction.
    """

    def work_rate(
        phase_number_of_interval: Indices, ellipse_number: Indices, angle_in_phase: Array
    ) -> Array:
        """l'/f Lam at angles (nodes, n) in the given phases (n,) of the given ellipses (n,). The
        angle [rad] is time: from the start of a phase on, or back from its end. The level l = +-Q -
        f P grows in slip; `kernel` gives Lam, the kernel of the friction work, from P and P - P_c,
        P_c the load at the stick edge.
        """
        level_rate_over_f, slip_zone_load, load = _rates_and_loads_in_intervals(
            ellipses, phase_number_of_interval, ellipse_number, angle_in_phase
        )
        return level_rate_over_f * kernel(load, np.minimum(slip_zone_load, load))

    # `corner_loads`: P or P_c where the edge of contact or of stick is at a corner. The results are
    # (phases, m) and (m,).
    works_of_phases, error_of_work = _integrals_by_group(
        ellipses,
        _intervals_of_phases(ellipses, contact.corner_loads, len(rules)),
        len(PHASE_NAMES),
        work_rate,
        rules,
        converged_share,
    )
    reverse_work, early_forward_work, late_forward_work = works_of_phases
    return np.stack([early_forward_work + late_forward_work, reverse_work, error_of_work])


def _intervals_of_phases(ellipses: Ellipses, corner_loads: Array, n_rules: int) -> AngleIntervals:
    """Intervals of angle [rad] in which the friction work is smooth, in each phase of slip of m
    load ellipses: E-G (reverse), I-J and J-M (forward).

    A phase is cut where the edge of contact or of stick passes a corner of the profile, of which
    `corner_loads` (n,) are the loads. Where there are two quadrature rules (`n_rules`), a whole
    phase takes the first one, an interval that ends at a corner the second one. Ellipses in which
    nothing slips have no interval.
    """
    # A corner that is nearly met counts too; permanent_stick_load: least load at the stick edge.
    is_above_least_load = corner_loads > 0.99 * np.min(
        ellipses.permanent_stick_load, initial=math.inf
    )
    is_below_largest_load = corner_loads < 1.01 * np.max(
        ellipses.mean_load + ellipses.load_amplitude, initial=0.0
    )
    corner_loads_in_range = corner_loads[is_above_least_load & is_below_largest_load, None]
    intervals_of_phases = []
    # (cuts, m) ascending, for each phase
    for phase_number, cut_angles in enumerate(
        cut_angles_of_phases(ellipses, corner_loads_in_range).values()
    ):
        has_length = np.diff(cut_angles, axis=0) > 1e-14 * cut_angles[-1]
        # intervals with a length, of ellipses in which something slips
        ellipse_number, cut_number = np.nonzero(
            has_length.T & (ellipses.slip_zone_load_scale > 0)[:, None]
        )
        begin_angle = cut_angles[cut_number, ellipse_number]
        end_angle = cut_angles[cut_number + 1, ellipse_number]
        # The second rule, if there is one, for intervals that end at a corner.
        is_part_of_phase = end_angle - begin_angle < cut_angles[-1, ellipse_number]
        rule_number = np.minimum(is_part_of_phase, n_rules - 1)
        intervals_of_phases.append(
            AngleIntervals.of_group(
                phase_number, ellipse_number, begin_angle, end_angle, rule_number
            )
        )
    return AngleIntervals.joined(intervals_of_phases)


def _rates_and_loads_in_intervals(
    ellipses: Ellipses,
    phase_number_of_interval: Indices,
    ellipse_number: Indices,
    angle_in_phase: Array,
) -> Array:
    """Rate of w/f = (+-Q - f P)/f per rad, P - P_c and P at angles (nodes, n) of n intervals,
    (3, nodes, n); P_c is the load at the stick edge.

    `phase_number_of_interval` (n,) is the number of each interval's phase of slip, in ascending
    order, and `ellipse_number` (n,) that of its ellipse. Angles count from the start of E-G
    (reverse slip) and I-J, and back from the end of J-M (forward slip). f is the friction.
    """
    rates_and_loads = np.empty((3, *angle_in_phase.shape))
    for phase_number, phase_name in enumerate(PHASE_NAMES):
        # the intervals of one phase, which stand side by side
        columns = slice(
            *np.searchsorted(phase_number_of_interval, [phase_number, phase_number + 1])
        )
        ellipses_of_columns = ellipses.take(ellipse_number[columns])
        for quantity, quantity_in_phase in zip(
            rates_and_loads,
            rate_and_loads_in_phase(phase_name, ellipses_of_columns, angle_in_phase[:, columns]),
            strict=True,
        ):
            quantity[:, columns] = quantity_in_phase
    return rates_and_loads


_COURSE_NAMES = ("P, E-G", "P, I-M", "P_c, E-G", "P_c, I-J", "P_c, J-M")


def _work_over_loads(
    ellipses: Ellipses, cut_loads: Array, log_half_width: Callable[[Array], Array]
) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), and the error of their sum,
    (3, m), from ln a alone; a is the contact half-width as a function of the load.

    The work in time is the integral of w'/f int_{P_c}^P ln(a(eta)/a(P_c)) d eta; w = +-Q - f P
    grows in slip. Integrated by parts, it has ln a(P) and ln a(P_c) with a weight each, and no
    inner integral.

    A course is one of the loads, P or P_c at the stick edge, through one phase of slip: E-G
    (reverse), I-J or J-M (forward); I-M is both of these. Courses are cut at the `cut_loads` (n,),
    between which `log_half_width`, ln a as a function of the load, is smooth. E* is the composite
    modulus, f the friction.
    """
    # ln a counts from that of P0, the mean load: what is left of any constant is round-off.
    log_at_mean_load = log_half_width(ellipses.mean_load[None])[0]

    def weighted_log(
        course_number_of_interval: Indices, ellipse_number: Indices, angle: Array
    ) -> Array:
        """Weight times ln(a/a(P0)) at angles (nodes, n) along the courses (n,) of ellipses (n,), a
        the contact half-width, P0 the mean load.
        """
        weight, load = _log_weights_and_loads_in_intervals(
            ellipses, course_number_of_interval, ellipse_number, angle
        )
        return weight * (log_half_width(load) - log_at_mean_load[ellipse_number])

    # (courses, m) and (m,). _COURSE_RULES: Gauss' rules of 8 to 24 nodes. An error check converges
    # below _CONVERGED_COEFFICIENT_SHARE = 3e-8 of W, or of 50 P0^2 where that is more.
    works_of_courses, error_of_work = _integrals_by_group(
        ellipses,
        _intervals_of_courses(ellipses, cut_loads),
        len(_COURSE_NAMES),
        weighted_log,
        _COURSE_RULES,
        _CONVERGED_COEFFICIENT_SHARE,
        _LEAST_WORK_OVER_SQUARED_LOAD,
    )
    (
        load_term_of_reverse_slip,
        load_term_of_forward_slip,
        stick_edge_term_of_reverse_slip,
        stick_edge_term_of_early_forward_slip,
        stick_edge_term_of_late_forward_slip,
    ) = works_of_courses
    # a last digit, 1e-15, of the square of the largest load
    error_of_work += _LAST_DIGIT_SHARE * np.square(ellipses.mean_load + ellipses.load_amplitude)
    forward_work = (
        load_term_of_forward_slip
        + stick_edge_term_of_early_forward_slip
        + stick_edge_term_of_late_forward_slip
    )
    reverse_work = load_term_of_reverse_slip + stick_edge_term_of_reverse_slip
    return np.stack([forward_work, reverse_work, error_of_work])


def _log_weights_and_loads_in_intervals(
    ellipses: Ellipses, course_number_of_interval: Indices, ellipse_number: Indices, angle: Array
) -> Array:
    """Weight of ln a per rad in the friction work, and the load, at angles (nodes, n) of n
    intervals, (2, nodes, n); a is the contact half-width under that load.

    A course is P, or P_c at the stick edge, through a phase of slip. `course_number_of_interval`
    (n,) is its number for each interval, in ascending order, and `ellipse_number` (n,) that of the
    ellipse. The angle is the variable of `log_weight_and_load`: t along P, for instance.
    """
    weights_and_loads = np.empty((2, *angle.shape))
    # _COURSE_NAMES: "P, E-G", "P, I-M", "P_c, E-G", "P_c, I-J", "P_c, J-M"
    for course_number, course_name in enumerate(_COURSE_NAMES):
        # the intervals of one course, which stand side by side
        columns = slice(
            *np.searchsorted(course_number_of_interval, [course_number, course_number + 1])
        )
        weight, load = log_weight_and_load(
            course_name, ellipses.take(ellipse_number[columns]), angle[:, columns]
        )
        weights_and_loads[0][:, columns] = weight
        weights_and_loads[1][:, columns] = load
    return weights_and_loads


class _Course(NamedTuple):
    """Range of angle [rad] of one course of m ellipses: P, or P_c at the stick edge, through a
    phase of slip.

    Attributes
    ----------
    first_angle, last_angle
        (m,) ends of the range
    inner_cuts
        angles, (c, m) each, at which the course is cut, if they lie within it
    load_is_cosine
        whether the load is P0 + P1 cos(angle), so that it grows from pi to 2 pi; else it grows with
        the angle
    """

    first_angle: Array
    last_angle: Array
    inner_cuts: tuple[Array, ...]
    load_is_cosine: bool


def _intervals_of_courses(ellipses: Ellipses, cut_loads: Array) -> AngleIntervals:
    """Intervals of angle [rad] in which friction work is integrated along the courses of the loads;
    in each the load is monotonic, and the contact half-width smooth.

    A course is P, or P_c at the stick edge, through one phase of slip. It is cut where its load is
    one of the `cut_loads` (n,), those of the profile's corners, for instance. The groups of
    intervals are the five courses: P in E-G (reverse slip), P in I-M (forward slip), P_c in E-G, in
    I-J and in J-M. An interval begins at its lower load, to which the nodes of the rules crowd.
    """
    intervals_of_courses = []
    for course_number, course in enumerate(_courses_of_loads(ellipses, cut_loads)):
        # first and last angle (m,), angles at which the course is cut if they are between, and
        # whether the load is P0 + P1 cos(angle)
        first_angle, last_angle, inner_cuts, load_is_cosine = course
        unsorted_angles = np.concatenate([first_angle[None], *inner_cuts, last_angle[None]])
        cut_angles = np.sort(
            np.clip(unsorted_angles, first_angle, np.maximum(first_angle, last_angle)), axis=0
        )
        ellipse_number, cut_number = np.nonzero((np.diff(cut_angles, axis=0) > 1e-14).T)
        begin_angle = cut_angles[cut_number, ellipse_number]
        end_angle = cut_angles[cut_number + 1, ellipse_number]
        if load_is_cosine:
            # The load grows from pi to 2 pi; where it falls the ends change places.
            load_grows = (begin_angle + end_angle) / (2 * math.pi) % 2 > 1
            begin_angle, end_angle = np.where(
                load_grows, [begin_angle, end_angle], [end_angle, begin_angle]
            )
        # one of five rules, by the length of the interval, up to 0.1, 0.3, 0.6, 1 rad and more
        rule_number = np.searchsorted(_COURSE_RULE_LENGTHS, np.abs(end_angle - begin_angle))
        intervals_of_courses.append(
            AngleIntervals.of_group(
                course_number, ellipse_number, begin_angle, end_angle, rule_number
            )
        )
    return AngleIntervals.joined(intervals_of_courses)


def _courses_of_loads(ellipses: Ellipses, cut_loads: Array) -> tuple[_Course, ...]:
    """The five courses of loads along which the friction work is integrated, each with its range of
    angle and the angles at which it is cut: P in E-G (reverse slip) and in I-M (forward slip), P_c
    in E-G, in I-J and in J-M.

    Integrated by parts, the work has ln a(P) and ln a(P_c), a the contact half-width. So a course
    is P, or P_c, through one phase of slip. P_c is the load at the stick edge,
    `permanent_stick_load` the least P_c. Cuts are where P or P_c is one of the `cut_loads` (n,),
    those of the profile's corners, for instance, and where P is largest or least. Along P the angle
    is the time t of P = P0 + P1 cos t. Along P_c in I-J it is 2 t_I - t, with t_I the start of
    forward slip. Along P_c in E-G and J-M it counts back from the end of the phase. E-G and J-M are
    `slip_angle` long; E-G begins at `slip_start`, and I half a turn later.
    """
    is_in_range = (cut_loads > 0.99 * np.min(ellipses.permanent_stick_load)) & (
        cut_loads < np.max(ellipses.mean_load + ellipses.load_amplitude)
    )
    loads_in_range = cut_loads[is_in_range, None]
    start_of_reverse_slip = ellipses.slip_start
    full_turn = 2 * math.pi
    # t in [0, pi] at which P is one of the loads; `load_moves` is False for constant P
    cosine_at_cut_load = (loads_in_range - ellipses.mean_load) / np.where(
        ellipses.load_moves, ellipses.load_amplitude, np.inf
    )
    angle_at_cut_load = np.arccos(np.clip(cosine_at_cut_load, -1.0, 1.0))
    # angles at which P_c is such a load, counted back from the end: in E-G and in J-M
    stick_edge_angle_in_reverse_slip, stick_edge_angle_in_late_forward_slip = _stick_edge_angles(
        ellipses, loads_in_range
    )
    zero_angles = np.zeros(len(start_of_reverse_slip))
    angle_of_least_load = np.full((1, len(start_of_reverse_slip)), math.pi)
    angle_of_largest_load = np.full((1, len(start_of_reverse_slip)), full_turn)
    cut_angles_of_load_in_reverse_slip = (
        angle_at_cut_load,
        angle_of_least_load,
        full_turn - angle_at_cut_load,
        angle_of_largest_load,
    )
    cut_angles_of_load_in_forward_slip = (
        full_turn - angle_at_cut_load,
        angle_of_largest_load,
        full_turn + angle_at_cut_load,
    )
    end_of_reverse_slip = start_of_reverse_slip + ellipses.slip_angle
    # load_is_cosine: the load is P0 + P1 cos(angle), P0 the mean load, P1 its amplitude
    load_course_of_reverse_slip = _Course(
        start_of_reverse_slip,
        end_of_reverse_slip,
        cut_angles_of_load_in_reverse_slip,
        load_is_cosine=True,
    )
    load_course_of_forward_slip = _Course(
        start_of_reverse_slip + math.pi,
        start_of_reverse_slip + full_turn,
        cut_angles_of_load_in_forward_slip,
        load_is_cosine=True,
    )
    stick_edge_course_of_reverse_slip = _Course(
        zero_angles,
        ellipses.slip_angle,
        (stick_edge_angle_in_reverse_slip,),
        load_is_cosine=False,
    )
    stick_edge_course_of_early_forward_slip = _Course(
        end_of_reverse_slip,
        start_of_reverse_slip + math.pi,
        (full_turn - angle_at_cut_load,),
        load_is_cosine=True,
    )
    stick_edge_course_of_late_forward_slip = _Course(
        zero_angles,
        ellipses.slip_angle,
        (stick_edge_angle_in_late_forward_slip,),
        load_is_cosine=False,
    )
    return (
        load_course_of_reverse_slip,
        load_course_of_forward_slip,
        stick_edge_course_of_reverse_slip,
        stick_edge_course_of_early_forward_slip,
        stick_edge_course_of_late_forward_slip,
    )


def log_weight_and_load(course_name: str, ellipses: Ellipses, angle: Array) -> tuple[Array, Array]:
    """Weight of ln a per rad in the friction work W pi E*/(2 f^2), and the load, shape of `angle`,
    along one course: P, or P_c at the stick edge, through a phase of slip.

    W, integrated by parts, is the integral of -w P' ln a(P) + (w P_c' - w' (P - P_c)) ln a(P_c)
    over the time of slip. The factors of ln a, over f, are the weights. w = +-Q - f P grows in slip
    and counts from its end; ' is d/dt.

    # notation: t_E (`slip_start`, with its sine and cosine), t_I times at which reverse and forward
    #           slip begin, P1 (`load_amplitude`) amplitude of P; u and v (`forward_amplitude`,
    #           `reverse_amplitude`) amplitudes of (Q -+ f P)/f; D (`slip_angle`) length of E-G and
    #           of J-M; E* composite modulus

    `course_name` is the load and the phase: "P, E-G", "P, I-M", "P_c, E-G", "P_c, I-J" or "P_c,
    J-M". E-G is reverse slip, I-M = I-J and J-M forward slip. a is the contact half-width. `angle`
    [rad] is the variable along the course: t for P, 2 t_I - t for P_c in I-J, else counted back
    from the end of the phase. One tangent of half of it stands for sine and cosine, since numpy has
    it in vector code.
    """
    tangent_of_half = np.tan(angle / 2)
    squared_tangent_of_half = tangent_of_half * tangent_of_half
    squared_cosine_of_half = 1 / (1 + squared_tangent_of_half)
    cosine = (1 - squared_tangent_of_half) * squared_cosine_of_half
    sine = 2 * tangent_of_half * squared_cosine_of_half
    if course_name == "P_c, E-G":
        return _log_weight_and_stick_edge_load(
            ellipses,
            ellipses.reverse_amplitude,
            ellipses.forward_amplitude,
            ellipses.slip_angle,
            squared_tangent_of_half * squared_cosine_of_half,
            cosine,
            sine,
        )
    if course_name == "P_c, J-M":
        return _log_weight_and_stick_edge_load(
            ellipses,
            ellipses.forward_amplitude,
            ellipses.reverse_amplitude,
            -ellipses.slip_angle,
            squared_tangent_of_half * squared_cosine_of_half,
            cosine,
            sine,
        )
    # P0 + P1 cos(angle), as a sum of positive terms
    load = (
        ellipses.mean_load - ellipses.load_amplitude
    ) + 2 * ellipses.load_amplitude * squared_cosine_of_half
    if course_name == "P_c, I-J":
        # cosine and sine of the angle from t_E
        cosine_from_start = ellipses.cosine_of_start * cosine + ellipses.sine_of_start * sine
        sine_from_start = ellipses.cosine_of_start * sine - ellipses.sine_of_start * cosine
        squared_sine_term = 2 * ellipses.sine_of_start * sine_from_start * sine_from_start
        weight_over_amplitudes = (1 - cosine_from_start) * sine + squared_sine_term
        return -ellipses.forward_amplitude * ellipses.load_amplitude * weight_over_amplitudes, load
    # along P: the phase ends at t_E + D, or at t_E a turn later
    if course_name == "P, E-G":
        level_amplitude = ellipses.reverse_amplitude
        end_angle = ellipses.slip_start + ellipses.slip_angle
    else:
        level_amplitude = ellipses.forward_amplitude
        end_angle = ellipses.slip_start
    cosine_to_end = np.cos(end_angle) * cosine + np.sin(end_angle) * sine
    return level_amplitude * ellipses.load_amplitude * sine * (cosine_to_end - 1), load


def _log_weight_and_stick_edge_load(
    ellipses: Ellipses,
    amplitude_of_stick_edge_load: Array,
    amplitude_of_slip_zone_load: Array,
    angle_at_no_slip: Array,
    squared_sine_of_half: Array,
    cosine: Array,
    sine: Array,
) -> tuple[Array, Array]:
    """Weight of ln a per rad in the friction work W pi E*/(2 f^2), and the load P_c, along the
    course of P_c in reverse slip (E-G) or later forward slip (J-M).

        P_c = P_T + `amplitude_of_stick_edge_load` `squared_sine_of_half`
        P - P_c = `amplitude_of_slip_zone_load`/2 (1 - cos(angle - `angle_at_no_slip`))

    The weight is w P_c' - w' (P - P_c), over f, from W by parts; w = +-Q - f P counts from its
    largest value. P_T (`permanent_stick_load`) is the load at the edge of the permanent stick zone,
    a the contact half-width. The angle counts back from the end of the phase.
    `squared_sine_of_half` is sin^2(angle/2); `cosine` and `sine` are of the angle. The two
    amplitudes are v, u in reverse slip and u, v in forward slip, those of (Q -+ f P)/f. E* is the
    composite modulus.
    """
    load_above_permanent_stick = amplitude_of_stick_edge_load * squared_sine_of_half
    cosine_from_no_slip = np.cos(angle_at_no_slip) * cosine + np.sin(angle_at_no_slip) * sine
    slip_zone_load = amplitude_of_slip_zone_load / 2 * (1 - cosine_from_no_slip)
    weight = amplitude_of_stick_edge_load * sine * (load_above_permanent_stick - slip_zone_load)
    return weight, ellipses.permanent_stick_load + load_above_permanent_stick


class _SumsOfIntervals(NamedTuple):
    """Sums over intervals of angle that have converged.

    A group is a phase of slip, or one load, P or P_c at the stick edge, through a phase.

    Attributes
    ----------
    works_of_groups
        (groups, m) friction work of each group and ellipse
    error_of_ellipse
        (m,) error of the work of each ellipse
    """

    works_of_groups: Array
    error_of_ellipse: Array

    def add(self, intervals: AngleIntervals, integrals: Array, errors: Array) -> None:
        """Add the integrals and errors of n intervals, (n,) each, to the sums of the groups and
        ellipses that these belong to.
        """
        np.add.at(
            self.works_of_groups, (intervals.group_number, intervals.ellipse_number), integrals
        )
        np.add.at(self.error_of_ellipse, intervals.ellipse_number, errors)


def _integrals_by_group(
    ellipses: Ellipses,
    intervals: AngleIntervals,
    n_groups: int,
    integrand: Callable[[Indices, Indices, Array], Array],
    rules: tuple[IntervalRule, ...],
    converged_share: float,
    least_work_over_squared_load: float = 0.0,
) -> tuple[Array, Array]:
    """Friction work W of m load ellipses by adaptive quadrature over the angle: integrals summed by
    group, (n_groups, m), and the error of W of each ellipse, (m,).

    A group is a phase of slip, or one load in it, P or that at the stick edge. Its angles are cut
    into intervals. An interval whose error check is too large is halved and integrated again. Where
    fifteen halvings do not converge the integral is NaN.

    Parameters
    ----------
    intervals
        the intervals: number of group and ellipse, first and last angle, number of the rule
    integrand
        function of arrays: numbers of group and ellipse (n,), and angle (nodes, n) of n intervals
    rules
        quadrature rules. The error check of a rule is a sum over its nodes that is 0 but for the
        error of the integral
    converged_share, least_work_over_squared_load
        an interval has converged if its error check is below `converged_share` times W, or times
        `least_work_over_squared_load` P0^2 where that is more, P0 the mean load. Fewer than 100
        ellipses take 0 for the latter, and the last rule alone
    """
    n_ellipses = len(ellipses.mean_load)
    if n_ellipses < _FEW_ELLIPSES:  # one rule: the number of calls costs, not the nodes
        intervals = intervals._replace(
            rule_number=np.full(len(intervals.rule_number), len(rules) - 1)
        )
        least_work_over_squared_load = 0.0
    squared_mean_load = np.square(ellipses.mean_load)
    sums = _SumsOfIntervals(np.zeros((n_groups, n_ellipses)), np.zeros(n_ellipses))
    check_limit = np.zeros(n_ellipses)
    remaining_intervals = intervals
    for n_halvings in range(_MOST_HALVINGS + 1):
        # of each interval, (n,): its integral, and the largest of its error checks
        integrals, largest_checks = _integrals_of_intervals(remaining_intervals, integrand, rules)
        ellipse_number = remaining_intervals.ellipse_number
        if not n_halvings:
            work_of_ellipse = np.bincount(ellipse_number, integrals, n_ellipses)
            reference_work = np.maximum(
                work_of_ellipse, least_work_over_squared_load * squared_mean_load
            )
            check_limit = converged_share * reference_work
        has_converged, interval_errors = _convergence_of_intervals(
            largest_checks,
            check_limit[ellipse_number],
            squared_mean_load[ellipse_number],
            n_halvings,
        )
        sums.add(
            remaining_intervals.take(has_converged),
            integrals[has_converged],
            interval_errors[has_converged],
        )
        # the others are halved
        remaining_intervals = remaining_intervals.take(~has_converged).halved()
        if not len(remaining_intervals.ellipse_number):
            break
    # what has not converged after fifteen halvings
    sums.works_of_groups[remaining_intervals.group_number, remaining_intervals.ellipse_number] = (
        np.nan
    )
    return sums.works_of_groups, sums.error_of_ellipse


def _convergence_of_intervals(
    largest_checks: Array, check_limit: Array, squared_mean_load: Array, n_halvings: int
) -> tuple[NDArray[np.bool_], Array]:
    """Whether the integral over each of n intervals of angle has converged, and an upper bound of
    its error, (n,) each.

    After three halvings an error check of 1e-14 P0^2 is enough, however small the friction work W
    is; P0 is the mean load. The error is at most 0.01 of the check where it is small, and 4 times
    the check where it is only negligible.

    Parameters
    ----------
    largest_checks
        (n,) the largest of sums over the interval that are 0 but for the error of the rule; NaN
        counts as converged
    check_limit
        (n,) a share of W; the check is small up to this
    squared_mean_load
        (n,) P0^2 of the ellipse that the interval belongs to
    n_halvings
        how many times the intervals have been halved
    """
    # not (>): NaN counts as converged
    is_check_small = ~(largest_checks > check_limit)
    # of P0^2: _NEGLIGIBLE_CHECK_SHARE = 1e-14
    is_check_negligible = largest_checks <= _NEGLIGIBLE_CHECK_SHARE * squared_mean_load
    # _FEW_HALVINGS = 3
    has_converged = is_check_small | ((n_halvings >= _FEW_HALVINGS) & is_check_negligible)
    interval_errors = largest_checks * np.where(
        is_check_small, _ERROR_OVER_SMALL_CHECK, _ERROR_OVER_LARGE_CHECK
    )
    return has_converged, interval_errors


def _integrals_of_intervals(
    intervals: AngleIntervals,
    integrand: Callable[[Indices, Indices, Array], Array],
    rules: tuple[IntervalRule, ...],
) -> tuple[Array, Array]:
    """Integral of a function over each of n intervals of angle [rad] by quadrature, (n,), and the
    largest error check of each, (n,).

    An error check is a weighted sum over the nodes that is 0 but for the error of the integral. The
    intervals of one rule are taken together, as many as fit the cache: 16,000 nodes.

    Parameters
    ----------
    intervals
        from `begin_angle` to `end_angle`; numbers of group, ellipse and quadrature rule of each
    integrand
        function of arrays: numbers of group and ellipse (n,), and angle (nodes, n)
    rules
        quadrature rules on [0, 1]: nodes as signed distances from one end, their weights, and those
        of the error checks
    """
    integrals = np.empty(len(intervals.ellipse_number))
    largest_checks = np.empty(len(intervals.ellipse_number))
    for rule_number, rule in enumerate(rules):
        interval_numbers_of_rule = np.flatnonzero(intervals.rule_number == rule_number)
        intervals_at_once = _INTERVAL_NODES_AT_ONCE // len(rule.weight)
        for first_interval_number in range(0, len(interval_numbers_of_rule), intervals_at_once):
            interval_numbers = interval_numbers_of_rule[
                first_interval_number : first_interval_number + intervals_at_once
            ]
            begin_angle = intervals.begin_angle[interval_numbers]
            end_angle = intervals.end_angle[interval_numbers]
            angle = (
                np.where(rule.is_from_lower_end, begin_angle, end_angle)
                + (end_angle - begin_angle) * rule.signed_distance
            )
            values_at_nodes = integrand(
                intervals.group_number[interval_numbers],
                intervals.ellipse_number[interval_numbers],
                angle,
            )
            interval_length = np.abs(end_angle - begin_angle)
            integrals[interval_numbers] = rule.weight @ values_at_nodes * interval_length
            largest_checks[interval_numbers] = (
                np.max(np.abs(rule.check_weights @ values_at_nodes), axis=0) * interval_length
            )
    return integrals, largest_checks


def _log_half_width_of(contact: SymmetricContact) -> Callable[[Array], Array]:
    """L(P) = ln of the contact half-width at loads P of any shape; ln(a/a_0) where the least
    half-width a_0 is that of a flat.
    """
    has_flat = contact.least_half_width > 0
    # `log_datum_ratio` is ln(2 datum_length/a).
    scaled_contact = replace(
        contact, datum_length=contact.least_half_width / 2 if has_flat else 0.5
    )
    return lambda load: -scaled_contact.log_datum_ratio(load)


class _CornerCoordinate(NamedTuple):
    """A coordinate along the loads of a profile with corners: the sum of sqrt(P - P_b) over them.

    From the load P_b of each corner it grows by v = sqrt(P - P_b), up to the load of the next
    corner. In v the logarithm of the contact half-width is smooth.

    Attributes
    ----------
    corner_loads
        (n,) ascending loads: 0, those under which the contact ends at a corner, and the largest
    corner_coordinates
        (n,) the coordinate at these loads
    """

    corner_loads: Array
    corner_coordinates: Array

    @classmethod
    def of_contact(
        cls, contact: SymmetricContact, first_octave: int, last_octave: int
    ) -> _CornerCoordinate:
        """The coordinate for loads up to 2^last_octave, or up to where the profile ends; corners
        count from the load 2^first_octave on.

        `contact` is the normal contact P(a) of the profile; its `extent` is the half-width where
        the profile ends, infinite where it does not.
        """
        largest_load = 2.0**last_octave
        if contact.extent != math.inf:
            largest_load = min(largest_load, float(contact.load(contact.extent)))
        is_in_range = (contact.corner_loads > 2.0**first_octave) & (
            contact.corner_loads < largest_load
        )
        corner_loads = np.array([0.0, *contact.corner_loads[is_in_range], largest_load])
        return cls(corner_loads, np.append(0.0, np.cumsum(np.sqrt(np.diff(corner_loads)))))

    def number_of_corner_below(self, coordinates: Array) -> Indices:
        """Number of the corner from which v is measured at each coordinate."""
        return np.searchsorted(self.corner_coordinates[1:-1], coordinates, side="right")

    def load_at(self, coordinates: Array) -> Array:
        """The load P = P_b + v^2 at coordinates of any shape."""
        corner_number = self.number_of_corner_below(coordinates)
        v = coordinates - self.corner_coordinates[corner_number]
        return self.corner_loads[corner_number] + np.square(v)

    def ends_of_first_ranges(self, first_octave: int) -> Array:
        """Ascending coordinates between which polynomials are first tried: the corners, and below
        the first corner ranges that halve the coordinate, down to that of the load 2^first_octave.
        """
        first_corner = self.corner_coordinates[1]
        n_octaves = max(math.ceil(math.log2(first_corner) - first_octave / 2), 1)
        octave_coordinates = first_corner * 2.0 ** np.arange(-n_octaves, 0)
        return np.append(octave_coordinates, self.corner_coordinates[1:])


class LogHalfWidth:
    """L(P) = ln a, a the contact half-width of any profile, by polynomials in v = sqrt(P - P_b)
    above the load P_b of each corner of the profile; from P = 0 on in octaves of v.

    Attributes
    ----------
    series_ends
        (n,) loads at which one polynomial ends and the next begins, without the outermost
    """

    def __init__(self, contact: SymmetricContact, first_octave: int, last_octave: int) -> None:
        """Polynomials of L = ln(half-width) for loads from 2^first_octave, or a little less, to
        2^last_octave, or to where the profile ends; below them L is constant. `contact` is the
        normal contact P(a) of the profile.

        The polynomials are set up along one coordinate, the sum of sqrt(P - P_b) over the loads P_b
        at which the contact ends at a corner of the profile. In v = sqrt(P - P_b) L is smooth.
        """
        coordinate_of_loads = _CornerCoordinate.of_contact(contact, first_octave, last_octave)
        # as a function of the load
        log_half_width = _log_half_width_of(contact)
        # Chebyshev series on ranges that are halved until they are resolved. The last argument
        # is the size of values beside which errors are negligible: 1, or more where P(a) is not
        # exact to round-off.
        series = piecewise_series_by_halving(
            lambda places: log_half_width(coordinate_of_loads.load_at(places)),
            coordinate_of_loads.ends_of_first_ranges(first_octave),
            max(contact.relative_roundoff / 4e-14, 1.0),
        )
        # for each polynomial: the load of the corner below it, and its coefficients
        corner_number = coordinate_of_loads.number_of_corner_below(series.interval_ends[:-1])
        self._corner_load = coordinate_of_loads.corner_loads[corner_number]
        # evaluated as powers, which is faster
        self._log_half_width = SeriesAsPowers(series.coefficients)
        # v at the two ends of each polynomial
        corner_coordinate = coordinate_of_loads.corner_coordinates[corner_number]
        self._first_v = series.interval_ends[:-1] - corner_coordinate
        self._last_v = series.interval_ends[1:] - corner_coordinate
        self.series_ends = (self._corner_load + np.square(self._first_v))[1:]

    def _values_of_series(self, series_number: Indices, v: Array) -> Array:
        """L = ln a, a the contact half-width, by the polynomials of the given numbers at v = sqrt(P
        - P_b), shape of v; P_b is the load of the profile's corner below each. `_first_v` and
        `_last_v` (n,) are the ends of the polynomials; within them the position goes from -1 to 1.
        """
        first_v = self._first_v[series_number]
        position = (v - first_v) * (2 / (self._last_v[series_number] - first_v)) - 1
        return self._log_half_width(
            np.broadcast_to(series_number, v.shape), np.clip(position, -1.0, 1.0)
        )

    def __call__(self, load: Array) -> Array:
        """L = ln a at loads (nodes, n); the loads of a column lie in one polynomial."""
        series_number = np.searchsorted(self.series_ends, load[len(load) // 2])
        return self._values_of_series(
            series_number, np.sqrt(np.maximum(load - self._corner_load[series_number], 0.0))
        )

    def dissipation_kernel_by_series(self, load: Array, slip_zone_load: Array) -> Array:
        """Kernel Lam of the friction work by polynomials of ln a, to 1e-16 of P - P_c; arrays of
        one shape.

        Lam = int_{P_c}^P [L(eta) - L(P_c)] d eta with L = ln a, a the contact half-width. P is
        `load`, P - P_c `slip_zone_load`, P_c the load at the stick edge. L is a polynomial in v =
        sqrt(P - P_b) above the load P_b of each corner of the profile. The integral goes from
        polynomial to polynomial (each a series) by Gauss' rule in v; the ends of the polynomials
        are `series_ends` as loads, `_first_v` and `_last_v` in v; `_corner_load` is the P_b of
        each.
        """
        stick_edge_load = load - slip_zone_load
        # of Gauss' rule with four nodes on [0, 1]
        nodes, weights = gauss_rule(4)
        # number of the polynomial that holds P_c, and of that which holds P
        series_number = np.searchsorted(self.series_ends, stick_edge_load)
        last_series_number = np.searchsorted(self.series_ends, load)
        v = np.sqrt(np.maximum(stick_edge_load - self._corner_load[series_number], 0.0))
        # L(P_c) by the polynomial
        log_at_stick_edge = self._values_of_series(series_number, v)
        kernel_integral = np.zeros(load.shape)
        remaining_load = slip_zone_load

        # one polynomial after the other
        for _ in range(int(np.max(last_series_number - series_number, initial=0)) + 1):
            load_to_end_of_series = np.square(self._last_v[series_number]) - v * v
            # up to the end of this polynomial, or to P in the last one
            load_range = np.clip(
                np.where(series_number < last_series_number, load_to_end_of_series, np.inf),
                0.0,
                remaining_load,
            )
            # v at the end minus v, without cancellation
            range_of_v = load_range / np.maximum(v + np.sqrt(v * v + load_range), 1e-300)
            v_at_nodes = v[..., None] + range_of_v[..., None] * nodes
            log_excess_at_nodes = (
                self._values_of_series(series_number[..., None], v_at_nodes)
                - log_at_stick_edge[..., None]
            )
            # d eta = 2 v dv
            kernel_integral += range_of_v * np.sum(
                weights * 2 * v_at_nodes * log_excess_at_nodes, axis=-1
            )
            remaining_load = remaining_load - load_range
            series_number = np.minimum(series_number + 1, last_series_number)
            v = np.where(remaining_load > 0, self._first_v[series_number], v)
        return kernel_integral


@lru_cache(maxsize=8)
def _cached_log_half_width(
    contact: SymmetricContact, first_octave: int, last_octave: int
) -> LogHalfWidth:
    """`LogHalfWidth` of a contact for loads from 2^first_octave to 2^last_octave, cached for the
    next group of ellipses.
    """
    return LogHalfWidth(contact, first_octave, last_octave)


# ------------------------------------------------ Hertz, power laws, flat and rounded faces: by Lam
# Nodes that are evaluated at once in one phase: arrays that fit into the cache.
_NODES_AT_ONCE = 16384
# Gauss rules on [0, 1], symmetric about the middle; the last one for singularities at the ends.
_NODE_COUNTS = (12, 14, 16, 18, 20, 23, 26, 32, 42)
_LAM_RULES = (*(gauss_rule(n_nodes) for n_nodes in _NODE_COUNTS), graded_nodes(0.0, 1.0))
_LEAST_HALF_SUMS_OF_DISTANCES = np.cosh(30.0 / (2 * np.array(_NODE_COUNTS)))[:, None]


def works_by_lam(
    ellipses: Ellipses,
    quick_kernel: BufferedKernel,
    careful_kernel: BufferedKernel,
    deep_share: float,
    least_share: float = _LEAST_SHARE_OF_MEAN_LOAD,
) -> tuple[Array, Array]:
    """Friction work W of forward and of reverse slip in the steady cycle of each load ellipse,
    times pi E*/(2 f^2), (m,) each [force^2 per thickness^2].

    For profiles whose kernel of the work is cheap. The kernel is Lam = int_{P_c}^P [ln a(eta) - ln
    a(P_c)] d eta; a multiple of Lam gives W times the same factor. Each ellipse gets as few nodes
    as it needs: one of the _LAM_RULES, nine Gauss rules and one for singular ends. Ellipses of one
    rule and one formula for Lam are integrated together. P_c is the load at the stick edge, a(eta)
    the contact half-width under the load eta. E* is the composite modulus, f the friction.

    Parameters
    ----------
    quick_kernel
        Lam to round-off of P - P_c; taken where the largest load P - P_c of the slip zones exceeds
        `deep_share` of the mean load P0, and each of u and v, the amplitudes of (Q -+ f P)/f,
        exceeds that share of the other
    careful_kernel
        Lam to round-off of itself; taken for all other ellipses
    deep_share
        least share of P0 for the quick kernel
    least_share
        loads below this share of P0 count as that share
    """
    # The same rule and the same kernel: one kind, integrated together. The kind is the number of
    # the rule times 2, plus 1 for the careful kernel.
    takes_careful_kernel = _takes_careful_kernel(ellipses, deep_share)
    kind_of_ellipse = 2 * _gauss_rule_numbers(ellipses) + takes_careful_kernel
    order_by_kind = np.argsort(kind_of_ellipse, kind="stable")
    # (9, m) angles and loads of the ellipses, in the order of their kinds
    parameters_by_kind = _phase_parameters(ellipses, least_share).take(order_by_kind, axis=1)
    # rows: reverse slip, later and earlier forward slip, without the constant factors
    sums_by_phase = np.empty((3, len(order_by_kind)))
    # For intermediate values: what is allocated once stays in the cache.
    buffer = np.empty(12 * max(_NODES_AT_ONCE, 64 * len(_LAM_RULES[-1][0])))
    for kind_number, columns in _blocks_of_kinds(kind_of_ellipse):
        sums_by_phase[:, order_by_kind[columns]] = phase_integrals(
            parameters_by_kind[:, columns],
            _LAM_RULES[kind_number // 2],
            careful_kernel if kind_number % 2 else quick_kernel,
            buffer,
        )
    return _works_of_sums(ellipses, sums_by_phase)


def _blocks_of_kinds(kind_of_ellipse: NDArray[np.uint8]) -> Iterator[tuple[int, slice]]:
    """Blocks of ellipses that are integrated together: number of their kind, and their columns when
    all m ellipses are sorted by kind.

    A kind is a quadrature rule and a formula for the kernel: `kind_of_ellipse` (m,) is twice the
    number of the rule, plus 0 or 1 for the formula. A block has as many ellipses as have 16,384
    nodes together, but at least 64.
    """
    ends_of_kinds = np.cumsum(np.bincount(kind_of_ellipse, minlength=2 * len(_LAM_RULES))).tolist()
    start_of_kind = 0
    for kind_number, end_of_kind in enumerate(ends_of_kinds):
        n_nodes = len(_LAM_RULES[kind_number // 2][0])
        ellipses_at_once = max(_NODES_AT_ONCE // n_nodes, 64)
        for start_of_block in range(start_of_kind, end_of_kind, ellipses_at_once):
            yield (
                kind_number,
                slice(start_of_block, min(start_of_block + ellipses_at_once, end_of_kind)),
            )
        start_of_kind = end_of_kind


def _works_of_sums(ellipses: Ellipses, sums_by_phase: Array) -> tuple[Array, Array]:
    """Friction work of forward and of reverse slip of m ellipses, times pi E*/(2 f^2), (m,) each:
    sums over quadrature nodes times the factors that are constant in a phase of slip.

    # notation: u, v (`forward_amplitude`, `reverse_amplitude`) amplitudes of (Q -+ f P)/f; P0, P1
    #           mean and amplitude of P; D (`slip_angle`) length of reverse slip E-G and of later
    #           forward slip J-M [rad], pi - D of earlier forward slip I-J; `sine_of_start`
    #           sin(t_E), t_E the start of E-G; P_c load at the stick edge; E* composite modulus; f
    #           friction

    `sums_by_phase` (3, m) are those of E-G, J-M and I-J. The factors are D v, D u and, in I-J,
    (pi - D) u over twice the largest P - P_c. There is no earlier forward slip where the slip zones
    carry less than 1e-200 of P0.
    """
    # the rates of slip, twice a product of sine and cosine, are summed without that factor 2
    integral_of_reverse_slip, integral_of_late_forward_slip, integral_of_early_forward_slip = (
        2 * sums_by_phase
    )
    twice_largest_slip_zone_load = 4 * ellipses.load_amplitude * ellipses.sine_of_start
    integral_of_early_forward_slip *= (
        (math.pi - ellipses.slip_angle)
        * ellipses.forward_amplitude
        / np.where(
            twice_largest_slip_zone_load > _LEAST_SHARE_OF_MEAN_LOAD * ellipses.mean_load,
            twice_largest_slip_zone_load,
            np.inf,
        )
    )
    return (
        integral_of_late_forward_slip * ellipses.slip_angle * ellipses.forward_amplitude
        + integral_of_early_forward_slip,
        integral_of_reverse_slip * ellipses.slip_angle * ellipses.reverse_amplitude,
    )


def _takes_careful_kernel(ellipses: Ellipses, deep_share: float) -> NDArray[np.bool_]:
    """Whether the quick formula for the kernel Lam of the friction work is not exact enough, (m,):
    `slip_zone_load_scale` is at most `deep_share` of P0, or one of u and v is at most that share
    of the other.

    # notation: u, v `forward_amplitude`, `reverse_amplitude`; P0 `mean_load`

    u and v are the amplitudes of (Q -+ f P)/f, a is the contact half-width. Lam is the integral of
    ln a - ln a(P_c) over the loads from P_c, that at the stick edge, to P. The slip zones carry
    P - P_c; its largest value in the cycle is `slip_zone_load_scale`, to a factor of two.
    """
    # Where u is almost 0, as at tangency, a phase of almost no slip would add rounding times v.
    has_unlike_amplitudes = np.minimum(
        ellipses.forward_amplitude, ellipses.reverse_amplitude
    ) <= deep_share * np.maximum(ellipses.forward_amplitude, ellipses.reverse_amplitude)
    has_shallow_slip = ellipses.slip_zone_load_scale <= deep_share * ellipses.mean_load
    return has_shallow_slip | has_unlike_amplitudes


def error_of_works_by_lam(
    ellipses: Ellipses, work: Array, deep_share: float, log_size: Array | float
) -> Array:
    """Upper bound of the error of the friction work by its kernel Lam, (m,), as of W pi E*/(2 f^2)
    [force^2 per thickness^2].

    Lam is the integral of ln a - ln a(P_c) over the loads from P_c, that at the stick edge, to P; a
    is the contact half-width. A quick or a careful formula gives it. The quick one is a difference,
    which loses the last digits of P times L, L = ln a. u and v (`forward_amplitude`,
    `reverse_amplitude`) are the amplitudes of (Q -+ f P)/f, P0 and P1 mean and amplitude of P. E*
    is the composite modulus.

    Parameters
    ----------
    work
        (m,) W pi E*/(2 f^2), forward and reverse slip together
    deep_share
        the quick formula is taken where the largest P - P_c exceeds this share of P0, and each of u
        and v exceeds this share of the other
    log_size
        size of L = ln a, (m,) or one for all
    """
    # 1e-15 of the largest load times u + v and the size of L
    roundoff_of_quick_kernel = (
        _LAST_DIGIT_SHARE
        * (ellipses.mean_load + ellipses.load_amplitude)
        * (ellipses.forward_amplitude + ellipses.reverse_amplitude)
        * log_size
    )
    # _RELATIVE_ERROR_OF_LAM_RULES: 5e-11, for what the quadrature rules leave out
    return (
        roundoff_error(ellipses, work)
        + _RELATIVE_ERROR_OF_LAM_RULES * np.abs(work)
        + np.where(_takes_careful_kernel(ellipses, deep_share), 0.0, roundoff_of_quick_kernel)
    )


def _gauss_rule_numbers(ellipses: Ellipses) -> NDArray[np.uint8]:
    """Number in `_LAM_RULES` of the Gauss rule with the fewest nodes that is good enough for the
    friction work of each ellipse, (m,); of the graded rule, the last, where none is.

    The error of Gauss' rule falls the faster, the farther the integrand's nearest singularity in
    the complex plane is from the interval. So this distance gives the number of nodes.

    # notation: P and P_c normal load and load at the edge of stick, P_T least P_c, P_min least P,
    #           P1 amplitude of P; u, v forward and reverse amplitude, of (Q -+ f P)/f; s angle from
    #           the start of E-G and I-J; D length of E-G and of J-M, pi - D that of I-J; t_E
    #           (`slip_start`) time t of E in P = P0 + P1 cos t; _LEAST_DIVISOR 1e-100

    "Good enough" leaves exp(-30) of the integrals over the phases of slip (reverse E-G, forward I-J
    and J-M). Gauss' rule of n nodes leaves about rho^(-2 n). Here rho + 1/rho is the sum of the
    distances of the nearest singularity from both ends of the interval [-1, 1]. In J-M and E-G the
    logarithm is singular where P_c = 0, at s = +-2 i arsinh(sqrt(P_T/u)) from M, and with v from G.
    Where P = 0 it is so +-2 i arsinh(sqrt(P_min/(2 P1))) beside t = pi, at s = pi - t_E in E-G and
    s = t_E in I-J; the mirror images in J-M and of I-J are farther away. Twelve nodes at least,
    since nearly without slip the integrand is a cube of sines.
    """
    length_of_reverse_slip = np.maximum(ellipses.slip_angle, _LEAST_DIVISOR)
    length_of_early_forward_slip = np.maximum(math.pi - ellipses.slip_angle, _LEAST_DIVISOR)
    larger_amplitude = np.maximum(ellipses.forward_amplitude, ellipses.reverse_amplitude)
    least_load = ellipses.mean_load - ellipses.load_amplitude
    # squares of twice the imaginary parts: where P_c = 0 and where P = 0
    squared_imaginary_at_no_stick = _square_of_imaginary(
        ellipses.permanent_stick_load, larger_amplitude
    )
    squared_imaginary_at_no_load = _square_of_imaginary(least_load, 2 * ellipses.load_amplitude)
    # Real part and squared imaginary part of singularities, each phase being the interval [-1, 1].
    # J-M is as long as E-G, and the larger of u and v serves both: one entry stands for P_c = 0 in
    # either. Which end of the interval it is beside makes no difference to the sum of distances.
    singularity_without_stick = (
        -1.0,
        squared_imaginary_at_no_stick / (length_of_reverse_slip * length_of_reverse_slip),
    )
    singularity_without_load_in_reverse_slip = (
        2 * (math.pi - ellipses.slip_start) / length_of_reverse_slip - 1,
        squared_imaginary_at_no_load / (length_of_reverse_slip * length_of_reverse_slip),
    )
    singularity_without_load_in_early_forward_slip = (
        2 * ellipses.slip_start / length_of_early_forward_slip - 1,
        squared_imaginary_at_no_load
        / (length_of_early_forward_slip * length_of_early_forward_slip),
    )
    half_sum_of_distances = np.full(len(length_of_reverse_slip), np.inf)
    singularities = (
        singularity_without_stick,
        singularity_without_load_in_reverse_slip,
        singularity_without_load_in_early_forward_slip,
    )
    for real_part, squared_imaginary_part in singularities:
        half_sum_at_singularity = _half_sum_of_distances(real_part, squared_imaginary_part)
        np.minimum(half_sum_of_distances, half_sum_at_singularity, out=half_sum_of_distances)
    # each rule has a least half sum of distances; the number of rules that need more
    return np.sum(half_sum_of_distances < _LEAST_HALF_SUMS_OF_DISTANCES, axis=0, dtype=np.uint8)


def _half_sum_of_distances(real_part: Array | float, squared_imaginary_part: Array) -> Array:
    """Half the sum of the distances of a complex place from 1 and from -1, the ends of the interval
    of Gauss' rule, (m,), by its real part and the square of its imaginary part.
    """
    distance_from_plus_1 = np.sqrt(np.square(real_part - 1) + squared_imaginary_part)
    distance_from_minus_1 = np.sqrt(np.square(real_part + 1) + squared_imaginary_part)
    return np.asarray((distance_from_plus_1 + distance_from_minus_1) / 2)


def _square_of_imaginary(least_load: Array, load_size: Array) -> Array:
    """Square of twice the imaginary part 2 arsinh(sqrt(least_load/load_size)) of a singularity,
    (m,): twice, since a phase of slip of length 1 is the interval [-1, 1] of length 2.
    """
    return np.square(4 * np.arcsinh(np.sqrt(least_load / np.maximum(load_size, _LEAST_DIVISOR))))


def _phase_parameters(ellipses: Ellipses, least_share: float) -> Array:
    """Angles [rad] and loads of m ellipses from which their friction work is integrated, rows (9,
    m): h, g, P_T, P_min, u, v, alpha, beta, k.

    # notation: h half the angle from E to G, g half of that from I to J; P_T permanent stick load,
    #           P_min least load, P1 amplitude of P; u, v forward and reverse amplitude, of (Q -+ f
    #           P)/f; alpha = sqrt(2 P1) sin(t_E/2), beta = sqrt(2 P1) cos(t_E/2), t_E time of E,
    #           the start of reverse slip, with its sine and cosine `sine_of_start`,
    #           `cosine_of_start`; k = 4 alpha beta

    E-G is reverse slip, I-J the first part of forward slip. Loads below `least_share` of the mean
    load count as that.
    """
    parameters = np.empty((9, len(ellipses.mean_load)))
    # the rows, filled in place
    h, g, permanent_stick_load, least_load, u, v, alpha, beta, k = parameters
    h[:] = ellipses.slip_angle / 2
    g[:] = (math.pi - ellipses.slip_angle) / 2
    # A permanent or least load of 0 as the smallest load there is: the logarithm of 0 is never
    # asked for.
    np.maximum(
        ellipses.permanent_stick_load, least_share * ellipses.mean_load, out=permanent_stick_load
    )
    np.maximum(
        ellipses.mean_load - ellipses.load_amplitude,
        least_share * ellipses.mean_load,
        out=least_load,
    )
    u[:] = ellipses.forward_amplitude
    v[:] = ellipses.reverse_amplitude
    # alpha and beta by half-angle formulas; the smaller one from alpha beta = P1 sin(t_E),
    # without cancellation.
    larger_of_alpha_and_beta = np.sqrt(
        ellipses.load_amplitude * (1 + np.abs(ellipses.cosine_of_start))
    )
    smaller_of_alpha_and_beta = (
        ellipses.load_amplitude
        * ellipses.sine_of_start
        / np.where(larger_of_alpha_and_beta > 0, larger_of_alpha_and_beta, 1.0)
    )
    is_alpha_larger = ellipses.cosine_of_start < 0
    alpha[:] = np.where(is_alpha_larger, larger_of_alpha_and_beta, smaller_of_alpha_and_beta)
    beta[:] = np.where(is_alpha_larger, smaller_of_alpha_and_beta, larger_of_alpha_and_beta)
    k[:] = 4 * ellipses.load_amplitude * ellipses.sine_of_start
    return parameters


def phase_integrals(
    parameters: Array, rule: tuple[Array, Array], lam_kernel: BufferedKernel, buffer: Array
) -> tuple[Array, Array, Array]:
    """Friction work of m load ellipses in each phase of slip, by quadrature over the angle: reverse
    slip (E-G), later (J-M) and earlier (I-J) forward slip, (m,) each.

    Factors that are constant in a phase are left out. P_c and P - P_c are written so that they are
    sums of positive terms, which lose no digits.

    # notation: P normal load, P_c load at the edge of stick, P_T least P_c, P_min least P, P1
    #           amplitude of P; u, v forward and reverse amplitude, of (Q -+ f P)/f; D angle from E
    #           to G, t_E time of E; h = D/2, g = (pi - D)/2, y node of [0, 1], nodes along axis 0,
    #           ellipses along axis 1; alpha = sqrt(2 P1) sin(t_E/2), beta = sqrt(2 P1) cos(t_E/2),
    #           k = 4 alpha beta = 4 P1 sin(t_E); a(eta) contact half-width under the load eta; f
    #           friction

    At the nodes S = sin(h y), C = cos(h y), Z = sin(g y) and X = cos(g y). A bar stands for the
    node 1 - y, which is one of the same rule. s is the angle in the phase of slip:

        E-G  s = D (1 - y)   rate 2 f v S C   P_c = P_T + v S^2
                                              P - P_c = u S-bar^2
        J-M  s = D y         rate 2 f u S C   P_c = P_T + u S^2
                                              P - P_c = v S-bar^2 + k S C
        I-J  s = 2 g y       rate 2 f u Z X   P_c = P_min + (alpha X - beta Z)^2
                                              P - P_c = k Z X

    The integrand is `lam_kernel` times S C in E-G and J-M, times P - P_c in I-J. One tangent a node
    stands for sine and cosine: numpy has it in vector code.

    Parameters
    ----------
    parameters
        (9, m) rows h, g, P_T, P_min, u, v, alpha, beta, k
    rule
        nodes y on [0, 1], symmetric about 1/2, and weights, (n,) each
    lam_kernel
        from P_c and P - P_c a multiple of Lam = int_{P_c}^P [ln a(eta) - ln a(P_c)] d eta, (phases,
        n, m) each
    buffer
        array for intermediate values, 12 n m at least: what is allocated once stays in the cache
    """
    nodes, weights = rule
    h, g, permanent_stick_load, least_load, u, v, alpha, beta, k = parameters
    shape = (4, 3, len(nodes), len(h))
    # P_c and P - P_c of all three phases, and arrays of intermediate values (3, n, m)
    stick_edge_loads, slip_zone_loads, scratch_arrays, kernel_buffer = buffer[
        : math.prod(shape)
    ].reshape(shape)
    (
        stick_edge_load_in_reverse_slip,
        stick_edge_load_in_late_forward_slip,
        stick_edge_load_in_early_forward_slip,
    ) = stick_edge_loads
    (
        slip_zone_load_in_reverse_slip,
        slip_zone_load_in_late_forward_slip,
        slip_zone_load_in_early_forward_slip,
    ) = slip_zone_loads
    tangent, sine_cosine, squared_secant = scratch_arrays

    # E-G and J-M
    # tan(h y) and 1 + tan^2(h y)
    _fill_tangent(nodes, h, tangent, squared_secant)
    np.divide(tangent, squared_secant, out=sine_cosine)
    squared_sine = tangent  # in the same memory
    squared_sine *= sine_cosine
    np.multiply(squared_sine, v, out=stick_edge_load_in_reverse_slip)
    np.multiply(squared_sine, u, out=stick_edge_load_in_late_forward_slip)
    slip_zone_load_in_reverse_slip[:] = stick_edge_load_in_late_forward_slip[::-1]
    np.multiply(sine_cosine, k, out=slip_zone_load_in_late_forward_slip)
    slip_zone_load_in_late_forward_slip += stick_edge_load_in_reverse_slip[::-1]
    stick_edge_loads[:2] += permanent_stick_load

    # I-J: (alpha X - beta Z)^2 is (alpha - beta tan)^2 X^2, tan, X and Z of g y
    _fill_tangent(nodes, g, tangent, squared_secant)
    np.divide(tangent, squared_secant, out=slip_zone_load_in_early_forward_slip)
    slip_zone_load_in_early_forward_slip *= k
    beta_times_tangent = tangent  # in the same memory, as are both below
    beta_times_tangent *= beta
    difference = np.subtract(alpha, beta_times_tangent, out=beta_times_tangent)
    squared_difference = np.multiply(difference, difference, out=difference)
    np.divide(squared_difference, squared_secant, out=stick_edge_load_in_early_forward_slip)
    stick_edge_load_in_early_forward_slip += least_load

    integrand = lam_kernel(stick_edge_loads, slip_zone_loads, kernel_buffer)
    integrand[:2] *= sine_cosine
    integrand[2] *= slip_zone_load_in_early_forward_slip
    return weights @ integrand[0], weights @ integrand[1], weights @ integrand[2]


def _fill_tangent(nodes: Array, angle: Array, tangent: Array, squared_secant: Array) -> None:
    """Write tan(angle y) and 1 + tan^2(angle y) into two arrays (n, m), for nodes y (n,) of [0, 1]
    and angles (m,).
    """
    np.multiply(nodes[:, None], angle, out=tangent)
    np.tan(tangent, out=tangent)
    np.multiply(tangent, tangent, out=squared_secant)
    squared_secant += 1


def quick_power_law_kernel(stick_edge_load: Array, slip_zone_load: Array, buffer: Array) -> Array:
    """Kernel n Lam of the friction work on a profile |x|^n (Hertz: n = 2), to round-off of P - P_c;
    arrays of one shape.

    Lam is the integral of ln(a/c) over the loads from P_c to P, with a and c the half-widths at
    that load and at P_c. As a^n is proportional to the load, n Lam = P ln(P/P_c) - P + P_c.

    P_c = `stick_edge_load` is the load at the stick edge, P - P_c = `slip_zone_load`. The result is
    written into `buffer` and returned; `stick_edge_load` is overwritten.
    """
    np.divide(slip_zone_load, stick_edge_load, out=buffer)
    np.log1p(buffer, out=buffer)
    load = stick_edge_load  # in the same memory
    load += slip_zone_load
    buffer *= load
    buffer -= slip_zone_load
    return buffer


def careful_power_law_kernel(stick_edge_load: Array, slip_zone_load: Array, buffer: Array) -> Array:
    """Kernel n Lam of the friction work on a profile |x|^n (Hertz: n = 2), to round-off of itself;
    arrays of one shape.

    Lam is the integral of ln(a/c) over the loads from P_c to P, with a and c the half-widths at
    that load and at P_c. As a^n is proportional to the load, n Lam = P ln(P/P_c) - P + P_c.

    P_c = `stick_edge_load` is the load at the stick edge, P - P_c = `slip_zone_load`. The array
    `stick_edge_load` is overwritten; `buffer` is not used. `log_excess(r)` is -ln(1 - r) - r
    without cancellation.
    """
    del buffer
    load = stick_edge_load  # in the same memory
    load += slip_zone_load
    return load * log_excess(slip_zone_load / load)


_CELL_BITS = 4
_CELLS_OF_OCTAVE = 1 << _CELL_BITS
_FRACTION_BITS = np.int64((1 << (52 - _CELL_BITS)) - 1)
_BITS_OF_ONE = np.int64(1023 << 52)
# Of the Chebyshev series through twelve points eight terms leave 1e-16; as powers of half its
# argument.
_CHEBYSHEV_POINTS = np.cos(math.pi * (np.arange(12) + 0.5) / 12)
_POWER_COUNT = 8
_CHEBYSHEV_POWERS = [
    np.pad(chebyshev.cheb2poly(row[: k + 1]), (0, _POWER_COUNT - 1 - k))
    for k, row in enumerate(np.eye(_POWER_COUNT))
]
_VALUES_TO_POWERS = 2.0 ** np.arange(_POWER_COUNT)[:, None] * (
    np.transpose(_CHEBYSHEV_POWERS)
    @ np.linalg.inv(chebyshev.chebvander(_CHEBYSHEV_POINTS, 11))[:_POWER_COUNT]
)
_RULE_FOR_CLOSE_LOADS = tuple(
    (float(node), float(weight * (1 - node))) for node, weight in zip(*gauss_rule(7), strict=True)
)


class LamTable:
    """Lam, the integral of ln a - ln a(P_c) over the loads from P_c to P, of a flat and rounded
    face: polynomials in P on sixteen cells of every octave (factor 2) between two loads.

        Lam(P, P_c) = J(P) - J(P_c) - (P - P_c) L(P_c),     J = int_0^P L d eta, L = ln a = dJ/dP
        where P_c is close to P:  (P - P_c)^2 int_0^1 (1 - z) L'(P_c + z (P - P_c)) dz

    The number of a cell is that of the leading bits of the load, so that there is no search. To
    1e-13. `largest_log_half_width` is the largest L in the table.
    """

    def __init__(self, contact: Contact, first_octave: int, last_octave: int) -> None:
        """Tabulate J = int_0^P ln a d eta, L = ln a and dL/dP of a contact as polynomials in P.
        Each octave of loads from 2^first_octave to 2^(last_octave + 1) has sixteen equal cells.

        a is the contact half-width over b, half the length of the flat. The kernel Lam of the
        friction work follows from J and L; dL/dP serves two loads close together, where differences
        of J and L lose digits. `contact` is that of a flat and rounded face, b its
        `least_half_width`. The cell number is the leading bits of the load: exponent (1023 for 1)
        and four bits of fraction. _CHEBYSHEV_POINTS are twelve points of [-1, 1]; _VALUES_TO_POWERS
        turns values there into coefficients of powers.
        """
        # number of the first cell by the leading bits of the load: exponent and four bits of
        # fraction
        self._first_cell = (1023 + first_octave) << _CELL_BITS
        octave, cell_in_octave = (
            grid.ravel() for grid in np.mgrid[first_octave : last_octave + 1, :_CELLS_OF_OCTAVE]
        )
        # loads at the twelve Chebyshev points of each cell, (cells, 12)
        load = np.ldexp(
            1 + (cell_in_octave[:, None] + (1 + _CHEBYSHEV_POINTS) / 2) / _CELLS_OF_OCTAVE,
            octave[:, None],
        )
        # `log_datum_ratio` is ln(2 datum_length/a), `approach_integral` its integral over the load.
        # With b = 2 datum_length L = ln(a/b) keeps its digits beside the flat.
        contact_with_datum = replace(contact, datum_length=contact.least_half_width / 2)
        integral_of_log = -contact_with_datum.approach_integral(load)
        log_half_width = -contact_with_datum.log_datum_ratio(load)
        # Over a short range of loads Lam is half of its square times L' at the load a third of the
        # range above the lower end, but for a share of 3e-14.
        load_range = 1e-6 * load
        with np.errstate(all="ignore"):
            slope_of_log = (
                2
                * contact_with_datum.dissipation_kernel(load + load_range * (2 / 3), load_range)
                / (load_range * load_range)
            )
        self.largest_log_half_width = float(np.max(log_half_width))
        # from values at the Chebyshev points to coefficients (powers, cells)
        self._integral_of_log = _VALUES_TO_POWERS @ integral_of_log.T
        self._log_half_width = _VALUES_TO_POWERS @ log_half_width.T
        self._slope_of_log = _VALUES_TO_POWERS @ slope_of_log.T

    def _cell_and_position(self, load: Array) -> tuple[NDArray[np.int64], Array]:
        """Number of the table's cell in which each load lies, and its position from -1/2 to 1/2 in
        the cell, shape of `load`.

        A cell is a sixteenth of an octave. So the bits of the floating-point number give both: the
        exponent and the leading _CELL_BITS = 4 bits of the fraction count the cells, the other bits
        are the position. `_first_cell` is the number of the first cell. _BITS_OF_ONE are the bits
        of 1.0, _FRACTION_BITS those behind the leading four. AssertionError for a load outside the
        table.
        """
        bits = load.view(np.int64)
        # the other bits of the fraction become a number from 1 to 2
        position_bits = bits & _FRACTION_BITS
        position_bits <<= _CELL_BITS
        position_bits |= _BITS_OF_ONE
        cell_number = bits >> (52 - _CELL_BITS)
        cell_number -= self._first_cell
        if cell_number.size and (
            cell_number.min() < 0 or cell_number.max() >= self._integral_of_log.shape[1]
        ):
            raise AssertionError("a load outside the table of Lam")
        return cell_number, position_bits.view(np.float64) - 1.5

    def quick_kernel(self, stick_edge_load: Array, slip_zone_load: Array, buffer: Array) -> Array:
        """Kernel Lam of the friction work by differences of tables, (phases, n, m): to some 1e-16
        of P^2 over P - P_c.

        Lam = int_{P_c}^P ln(a(eta)/a(P_c)) d eta = J(P) - J(P_c) - (P - P_c) L(P_c). The tables
        hold J = int_0^P ln a d eta (`_integral_of_log`) and L = ln a, as polynomials in P on each
        cell of loads. a is the contact half-width, P_c the load at the stick edge.

        P_c = `stick_edge_load` and P - P_c = `slip_zone_load`, of the same shape. The result is
        written into `buffer` and returned.
        """
        # one phase after the other: it stays in the cache
        for stick_edge_load_in_phase, slip_zone_load_in_phase, lam_in_phase in zip(
            stick_edge_load, slip_zone_load, buffer, strict=True
        ):
            # number of the table's cell, and position in it, of P (0) and of P_c (1)
            cell_number, position = self._cell_and_position(
                np.stack(
                    [stick_edge_load_in_phase + slip_zone_load_in_phase, stick_edge_load_in_phase]
                )
            )
            integral_to_load, integral_to_edge = _polynomials_at(
                self._integral_of_log, cell_number, position
            )
            integral_to_load -= integral_to_edge
            log_at_edge = _polynomials_at(self._log_half_width, cell_number[1], position[1])
            np.multiply(slip_zone_load_in_phase, log_at_edge, out=lam_in_phase)
            np.subtract(integral_to_load, lam_in_phase, out=lam_in_phase)
        return buffer

    def careful_kernel(self, stick_edge_load: Array, slip_zone_load: Array, buffer: Array) -> Array:
        """Kernel of the friction work, Lam = int_{P_c}^P ln(a(eta)/a(P_c)) d eta, (phases, n, m),
        to 1e-13 of itself.

        P_c = `stick_edge_load` and P - P_c = `slip_zone_load`, of the same shape; `buffer` is
        overwritten. Where P - P_c is below 3/7 P_c, Lam is (P - P_c)^2 times the integral of
        (1 - z) L' over z from 0 to 1. L' is d ln a/dP at P_c + z (P - P_c), from a table of
        polynomials on cells of loads. a is the contact half-width, P_c the load at the stick edge.
        Elsewhere it is the difference of tables by `quick_kernel`.
        """
        integral_of_slope = np.zeros(stick_edge_load.shape)
        # Gauss' nodes z of [0, 1], and weights that include 1 - z
        for z, weight in _RULE_FOR_CLOSE_LOADS:
            load_at_node = stick_edge_load + z * slip_zone_load
            slope_at_node = _polynomials_at(
                self._slope_of_log, *self._cell_and_position(load_at_node)
            )
            integral_of_slope += weight * slope_at_node
        return np.where(
            0.7 * slip_zone_load < 0.3 * stick_edge_load,
            integral_of_slope * slip_zone_load * slip_zone_load,
            self.quick_kernel(stick_edge_load, slip_zone_load, buffer),
        )


def _polynomials_at(
    coefficients_of_cells: Array, cell_number: NDArray[np.int64], position: Array
) -> Array:
    """Values of the table's polynomials in the given cells at positions from -1/2 to 1/2 in them,
    shape of `cell_number`. `coefficients_of_cells` is (powers from the lowest, cells).
    """
    values = coefficients_of_cells[-1].take(cell_number, mode="clip")
    coefficients = np.empty(cell_number.shape)
    for coefficients_of_power in coefficients_of_cells[-2::-1]:
        values *= position
        values += coefficients_of_power.take(cell_number, mode="clip", out=coefficients)
    return values
