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
own corners, and pieces crowd to their lower loads: L is a smooth function of sqrt(P - P_b).

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
from scenes.chebyshev import Powers, halved
from semi_analytic.hertz import log_excess
from semi_analytic.profiles import Contact, SymmetricContact
from semi_analytic.quadrature import ROOTS, gauss, graded

Indices = NDArray[np.intp]

PHASES = ("E-G", "I-J", "J-M")
# Nodes of pieces at once: arrays of 128 kB and more get fresh memory at every call, which costs
# half as much again. Points at once.
_ELEMENTS = 16000
_POINTS = 500
# A piece has converged where every second node alone changes this share of W, which leaves 2e-14 or
# less (10 times as much where P hardly grows), or after a few halvings this share of P0^2; it is
# halved so often at most.
_CONVERGED = 1e-9
_FEW = 3
_NOTHING = 1e-14
_HALVINGS = 15


@dataclass(frozen=True, eq=False)
class Ellipses:
    """Steady ellipses, turned the way round that has 0 <= phase <= pi; all arrays of shape (m,).

    Attributes
    ----------
    mean_load, load_amplitude
        P0, P1
    u, v
        amplitudes of (Q -+ f P)/f
    cosine_of_start, sine_of_start
        of t_E, at which reverse slip begins
    slip_angle
        D, that of reverse slip, E to G
    permanent_stick_load
        P_T
    """

    mean_load: Array
    load_amplitude: Array
    u: Array
    v: Array
    cosine_of_start: Array
    sine_of_start: Array
    slip_angle: Array
    permanent_stick_load: Array

    def take(self, members: Any) -> Ellipses:
        """Some of them, in the shape of `members`."""
        return Ellipses(**{name: values[members] for name, values in vars(self).items()})

    def over(self, unit: Array) -> Ellipses:
        """The ellipses with every load divided by a unit of force per thickness, (m,)."""
        loads = {
            name: vars(self)[name] / unit
            for name in ("mean_load", "load_amplitude", "u", "v", "permanent_stick_load")
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
    def deepest_slip(self) -> Array:
        """Largest P - P_c: at the ends of E-G and J-M, or within I-J."""
        tangent = np.tan(self.slip_angle / 2)
        square = tangent * tangent
        ends = np.maximum(self.u, self.v) * square / (1 + square)
        sine = np.where(tangent > 1, 2 * tangent / (1 + square), 1.0)
        return np.maximum(ends, 2 * self.load_amplitude * self.sine_of_start * sine)

    def load(self, cosine: Array | float) -> Array:
        """P where cos t is known, from the least load so that it keeps its digits close to full
        unloading.
        """
        return (self.mean_load - self.load_amplitude) + self.load_amplitude * (1 + cosine)


def ellipses_of(
    mean: Array, amplitude: Array, tangential_amplitude: Array, phase: Array, friction: Array
) -> Ellipses:
    """Loads and angles of steady load loops that the slip of a contact needs, from P = P0 + P1 cos
    t, Q = Q0 + Q1 cos(t - phase).

    Among them are the amplitudes u, v of (Q -+ f P)/f, the time t_E at which reverse slip begins,
    its duration in angle, and the load P_T of the permanent stick zone. Q0 plays no part in the
    steady state.

    Parameters
    ----------
    mean, amplitude, tangential_amplitude
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
    # notation: r exp(-i phase) = along_axis - i across_axis, r = Q1/f
    shear_over_friction = tangential_amplitude / friction
    # cos and sin of the phase from half of it; the mirrored loop, Q -> -Q, goes round the other
    # way: phase + pi.
    half_tangent = np.tan(phase / 2)
    scaled_shear = shear_over_friction / (1 + half_tangent * half_tangent)
    along_axis = (
        np.where(half_tangent < 0, -1.0, 1.0)
        * scaled_shear
        * (1 - half_tangent)
        * (1 + half_tangent)
    )
    across_axis = 2 * scaled_shear * np.abs(half_tangent)
    u = np.hypot(along_axis - amplitude, across_axis)
    v = np.hypot(along_axis + amplitude, across_axis)
    positive_u = np.where(u > 0, u, 1.0)
    difference_of_squares = (amplitude - shear_over_friction) * (amplitude + shear_over_friction)
    return Ellipses(
        mean_load=mean,
        load_amplitude=amplitude,
        u=u,
        v=v,
        cosine_of_start=(along_axis - amplitude) / positive_u,
        sine_of_start=across_axis / positive_u,
        slip_angle=np.arctan2(2 * amplitude * across_axis, difference_of_squares),
        # P_T < 0 is admitted to rounding only: it is gross sliding.
        permanent_stick_load=np.maximum(mean - (u + v) / 2, 0.0),
    )


def phase_of(name: str, ellipses: Ellipses, s: Array) -> tuple[Array, Array, Array]:
    """Slip of each ellipse at angles `s` after the begin of one phase of slip: growth rate of the
    slip force over f, the load P - P_c of the slip zones, and P.

    Reverse slip is phase "E-G", forward slip "I-J" and then "J-M", the `name`. P_c is the load at
    which the edge of contact would be at the stick edge. Angles are in rad. Tangents of half the
    angles stand for sines: numpy has them in vector code.
    """
    if name == "I-J":
        sine_of_rate, _ = _sine_and_square(s)
        _, squared_sine_of_half_time = _sine_and_square(ellipses.slip_start + s)
        return (
            ellipses.u * sine_of_rate,
            2 * ellipses.load_amplitude * ellipses.sine_of_start * sine_of_rate,
            ellipses.load(2 * squared_sine_of_half_time - 1),
        )
    if name == "E-G":
        sine_of_rate, _ = _sine_and_square(ellipses.slip_angle - s)
        _, squared_sine_of_slip = _sine_and_square(s)
        _, squared_sine_of_half_time = _sine_and_square(ellipses.slip_start + s)
        rate = ellipses.v * sine_of_rate
        slipped = ellipses.u * squared_sine_of_slip
    else:
        sine_of_rate, _ = _sine_and_square(s)
        _, squared_sine_of_slip = _sine_and_square(ellipses.slip_angle + s)
        _, squared_sine_of_half_time = _sine_and_square(ellipses.slip_start - s)
        rate = ellipses.u * sine_of_rate
        slipped = ellipses.v * squared_sine_of_slip
    return rate, slipped, ellipses.load(1 - 2 * squared_sine_of_half_time)


def _sine_and_square(angle: Array) -> tuple[Array, Array]:
    """sin of an angle, and sin^2 of half of it."""
    tangent = np.tan(angle / 2)
    secant_square = 1 + tangent * tangent
    return 2 * tangent / secant_square, tangent * tangent / secant_square


def half_angle(part: Array) -> Array:
    """2 arcsin(sqrt(part)), of 0 below 0 and of 1 above 1."""
    return 2 * np.arcsin(np.sqrt(np.clip(part, 0.0, 1.0)))


def _stick_edge_angles(e: Ellipses, loads: Array) -> tuple[Array, Array]:
    """Angles at which the stick edge is at given loads P: 2 arcsin of the roots of (P - P_T)/v and
    of (P - P_T)/u, for the phases of slip E-G and J-M.
    """
    load_above = np.maximum(loads - e.permanent_stick_load, 0.0)
    by_v = half_angle(load_above / np.where(e.v > 0, e.v, np.inf))
    by_u = half_angle(load_above / np.where(e.u > 0, e.u, np.inf))
    return by_v, by_u


def corner_angles(ellipses: Ellipses, corners: Array) -> dict[str, Array]:
    """Angles at which each phase of slip is cut so that its integrands are smooth, by the name of
    the phase, (cuts, m), ascending.

    A phase ("E-G" reverse slip, "I-J" and "J-M" forward slip) is cut at its ends, and where the
    edge of contact or of stick passes a corner of the profile. There P or P_c, the load at the
    stick edge, equals one of the `corners` (c, 1).
    """
    cosine_at_corner = (corners - ellipses.mean_load) / np.where(
        ellipses.load_moves, ellipses.load_amplitude, np.inf
    )
    # Corners that are not met, but nearly: a cut at the greatest or least load.
    rising_angle = np.arccos(np.clip(cosine_at_corner, -1.0, 1.0))
    falling_angle = np.arccos(np.clip(-cosine_at_corner, -1.0, 1.0))
    stick_edge_angle_by_v, stick_edge_angle_by_u = _stick_edge_angles(ellipses, corners)
    start_angle = ellipses.slip_start
    full_turn = 2 * math.pi
    inner_cuts = {
        "E-G": (
            rising_angle - start_angle,
            full_turn - rising_angle - start_angle,
            ellipses.slip_angle - stick_edge_angle_by_v,
        ),
        "I-J": (
            falling_angle - start_angle,
            full_turn - falling_angle - start_angle,
            start_angle - falling_angle,
            start_angle + falling_angle,
        ),
        "J-M": (start_angle - rising_angle, start_angle + rising_angle, stick_edge_angle_by_u),
    }
    lengths = {
        "E-G": ellipses.slip_angle,
        "I-J": math.pi - ellipses.slip_angle,
        "J-M": ellipses.slip_angle,
    }
    angles = {}
    for name, length in lengths.items():
        cuts = np.concatenate([np.zeros_like(start_angle)[None], *inner_cuts[name], length[None]])
        angles[name] = np.sort(np.clip(cuts, cuts[0], cuts[-1]), axis=0)
    return angles


def quadrature_error(values: Array, size: Array) -> Array:
    """Error of an integral over `size`, from above, by three values of it: by all nodes of one
    rule, by every second node, by every fourth.

    It is the difference of the first two. Where that falls like an exponential, as for smooth
    integrands, it is the power 1.5 of it; the power 2 would be just.
    """
    positive_size = np.where(size > 0, size, 1.0)
    by_all, by_second, by_fourth = values
    # of slips of 1e-265 too
    difference = np.minimum(np.abs(by_all - by_second) / positive_size, 1e100)
    coarser_difference = np.minimum(np.abs(by_second - by_fourth) / positive_size, 1e100)
    return np.where(difference <= coarser_difference**1.5, difference**1.5, difference)


def density_of(
    ellipses: Ellipses, contact: Contact, x: Array, node_stride: int = 1
) -> tuple[Array, Array]:
    """Friction work per area W(x) of each ellipse at its own point |x| = x[k], times pi E*/(2 f^2):
    that of forward slip and that of reverse slip, (m,) each.

    `contact` is the normal contact P(a) of the profile. With `node_stride` = 2 every second node of
    the quadrature rule is taken, which is right to some 1e-6.
    """
    works = np.zeros((len(PHASES), len(x)))
    for first_point in range(0, len(x), _POINTS):
        points_at_once = np.arange(first_point, min(first_point + _POINTS, len(x)))
        works[:, points_at_once] = _densities(
            ellipses.take(points_at_once[:, None]), contact, x[points_at_once, None], node_stride
        )
    return works[1] + works[2], works[0]


def _densities(ellipses: Ellipses, contact: Contact, x: Array, node_stride: int) -> Array:
    """Friction work per area W(x) pi E*/(2 f^2) of each phase of slip, (3, m), for ellipse k at |x|
    = x[k]: the integral of p, slip rate and arccosh(|x|/c) over the time.

    The phases are E-G, reverse slip, and I-J, J-M, forward slip. `ellipses` and `x` are columns (m,
    1); `node_stride` 2 takes every second node of the rule.
    """
    load_at_x = contact.load(x)
    ranges_of_slip = _ranges_of_slip(ellipses, load_at_x)
    cuts_of_phases = list(
        corner_angles(ellipses.take((slice(None), 0)), contact.break_loads[:, None]).values()
    )
    density = np.zeros((len(PHASES), len(x)))
    for phase_number, begin, end in ranges_of_slip:
        inner_cuts = np.clip(cuts_of_phases[phase_number].T, begin, np.maximum(begin, end))
        cuts = np.concatenate([begin, inner_cuts, end], axis=1)
        ellipse_of_part, number_of_cut = np.nonzero(cuts[:, 1:] > cuts[:, :-1])
        if not len(ellipse_of_part):
            continue
        angle_in_phase, weights = graded(
            cuts[ellipse_of_part, number_of_cut],
            cuts[ellipse_of_part, number_of_cut + 1],
            node_stride,
        )
        rate, slipped, load = phase_of(
            PHASES[phase_number], ellipses.take(ellipse_of_part), angle_in_phase
        )
        stick_edge_load = np.maximum(load - slipped, 0.0)
        load_excess = np.maximum(load_at_x[ellipse_of_part] - stick_edge_load, 0.0)
        arccosh_ratio = contact.arccosh_ratio(
            x[ellipse_of_part], load_excess, contact.advance(stick_edge_load)
        )
        works_at_nodes = weights * rate * contact.pressure(x[ellipse_of_part], load) * arccosh_ratio
        np.add.at(density[phase_number], ellipse_of_part, np.sum(works_at_nodes, axis=1))
    return density


def _ranges_of_slip(ellipses: Ellipses, load_at_x: Array) -> tuple[tuple[int, Array, Array], ...]:
    """Angles between which a point slips in each phase of slip: number of the phase, first and last
    angle from the begin of the phase, (m, 1) each.

    # notation: P1 amplitude of P; P_x load at which the edge of contact is at x, P_T least load at
    #           the edge of stick, P_min least P; u, v amplitudes of (Q -+ f P)/f; D angle from E to
    #           G, s angle from the begin of a phase, t_E time of E

    The phases are E-G, reverse slip, and I-J, J-M, forward slip. The point is in contact for
    pi + h < t < 3 pi - h; 2 h is the angle about the least load within which it is open,
    2 P1 sin^2(h/2) = P_x - P_min. The stick edge passes it in E-G where sin^2((D - s)/2) = (P_x -
    P_T)/v, in I-J at s = t_E - h, in J-M where sin^2(s/2) = (P_x - P_T)/u.
    """
    share_of_load_range = (load_at_x - ellipses.mean_load + ellipses.load_amplitude) / np.where(
        ellipses.load_moves, 2 * ellipses.load_amplitude, 1.0
    )
    share_at_rest = np.where(load_at_x > ellipses.mean_load, 1.0, 0.0)
    open_angle = half_angle(np.where(ellipses.load_moves, share_of_load_range, share_at_rest))
    start_angle = ellipses.slip_start
    phase_angle = ellipses.slip_angle
    stick_edge_angle_by_v, stick_edge_angle_by_u = _stick_edge_angles(ellipses, load_at_x)
    passing_angle = np.maximum(phase_angle - stick_edge_angle_by_v, 0.0)
    # E-G before and after the least load, I-J, J-M
    return (
        (0, passing_angle, np.minimum(phase_angle, math.pi - open_angle - start_angle)),
        (0, np.maximum(passing_angle, math.pi + open_angle - start_angle), phase_angle),
        (
            1,
            np.abs(start_angle - open_angle),
            np.minimum(math.pi - phase_angle, 2 * math.pi - open_angle - start_angle),
        ),
        (
            2,
            np.maximum(0.0, start_angle - math.pi + open_angle),
            np.minimum(
                np.minimum(phase_angle, stick_edge_angle_by_u), start_angle + math.pi - open_angle
            ),
        ),
    )


Area = Callable[[Array, Array, Array], Array]
"""Some multiple of Lam(P, P_c) from P_c, P - P_c and a free array, (phases, n, m) each; may
overwrite all but the second.
"""

_TINY = 1e-100
_FLOOR = 1e-200


# ------------------------------------------------- any profile: pieces of phases, and series of Lam


class PieceRule(NamedTuple):
    """Nodes on [0, 1], (n, 1), by the way from an end, `lower` or not, to each; weights (n,) and
    checks (k, n).

    A check is a sum that is 0 but for what the rule leaves out.
    """

    way: Array
    lower: NDArray[np.bool_]
    weight: Array
    check: Array


def _halves() -> PieceRule:
    """The graded rule, and what every second of its nodes alone makes of it."""
    weight = graded(0.0, 1.0)[1]
    check = weight.copy()
    check[::2] -= 2 * weight[::2]
    is_lower = ROOTS.up[:, None] < 0.5
    way = np.where(is_lower, ROOTS.up[:, None], -ROOTS.down[:, None])
    return PieceRule(way, is_lower, weight, check[None])


def _legendre(count: int, crowded_ends: int) -> PieceRule:
    """Gauss' rule of `count` nodes on [0, 1] for integrands with roots at the ends, with its last
    three Legendre coefficients as checks of its error.

    A change of variable makes roots smooth and crowds the nodes: t^2 to the lower end
    (`crowded_ends` = 1), 3 t^2 - 2 t^3 to both (2), none (0).
    """
    node, weights = gauss(count)
    orders = np.arange(count - 3, count)
    polynomials = legendre.legvander(2 * node - 1, count - 1)[:, orders].T
    checks = polynomials * (2 * orders[:, None] + 1)
    if crowded_ends == 0:
        return PieceRule(node[:, None], np.array(True), weights, weights * checks)
    if crowded_ends == 1:
        weights = weights * 2 * node
        return PieceRule(node[:, None] ** 2, np.array(True), weights, weights * checks)
    to_end = np.minimum(node, 1 - node)
    is_lower = node[:, None] < 0.5
    weights = weights * 6 * node * (1 - node)
    distance_to_end = (to_end * to_end * (3 - 2 * to_end))[:, None]
    return PieceRule(
        np.where(is_lower, distance_to_end, -distance_to_end), is_lower, weights, weights * checks
    )


# For all that is singular; for pieces without corners, and for others; for those of one course, by
# length up to these [rad].
_GRADED = (_halves(),)
_QUICK = (_legendre(20, 0), _legendre(24, 2))
_BEHIND = tuple(_legendre(count, 1) for count in (8, 10, 12, 16, 24))
_SHORT = np.array([0.1, 0.3, 0.6, 1.0])
# The same for the three last coefficients: they fall like a power where two corners are close, and
# leave 1e-3 of themselves; in courses of loads so many times P0^2 of W are enough: they leave 2e-12
# of P0^2 where P hardly grows, 1e-14 elsewhere.
_SETTLED = 3e-8
_ENOUGH = 50.0
# Of the check of a piece, how much its integral is wrong at most: where the piece has converged,
# and where W is too small for that.
_LEFT = 1e-2
_ROUGHLY_LEFT = 4.0
# Shares of P0 down to which P - P_c goes by L at P and at P_c, and by L between them: they keep
# 1e-10 of Lam.
_DEEP = 0.002
_SHALLOW = 1e-6
# Fewer members than these go by one rule, and so few without a table.
_SOME = 100
_DIRECT = 8

Kernel = Callable[[Array, Array], Array]
"""Lam from P and P - P_c, (nodes, pieces) each."""


class Pieces(NamedTuple):
    """Pieces of integrals, (n,) each, sorted by group: group, member, begin, end and the number of
    the rule.
    """

    group: Indices
    member: Indices
    begin: Array
    end: Array
    rule: Indices

    @classmethod
    def of_group(
        cls, group: int, member: Indices, low: Array, high: Array, rule: Indices
    ) -> Pieces:
        """Pieces of the integrals of one group, between the angles `low` and `high`."""
        return cls(np.full(len(member), group), member, low, high, rule)

    @classmethod
    def together(cls, parts: Sequence[Pieces]) -> Pieces:
        """All of some, one after the other."""
        return cls._make(np.concatenate(column) for column in zip(*parts, strict=True))

    def take(self, numbers: Indices | NDArray[np.bool_]) -> Pieces:
        """The chosen ones."""
        return Pieces._make(column[numbers] for column in self)

    def halved(self) -> Pieces:
        """Both halves of each side by side: groups stay in order."""
        middle = (self.begin + self.end) / 2
        return Pieces(
            group=np.repeat(self.group, 2),
            member=np.repeat(self.member, 2),
            begin=np.ravel([self.begin, middle], order="F"),
            end=np.ravel([middle, self.end], order="F"),
            rule=np.repeat(self.rule, 2),
        )


# Of W, and of the last digits of loads and angles: how many of them their errors are.
_RELATIVE = 2e-12
_DIGITS = 1e-15
_OF_SERIES = 1e-13
# Of a loop: a power of three of its amplitudes, and as much for their angles.
_OF_LOOP = 6.0
# Of W: what the rules leave out that are picked by where Lam is singular; at most 1.7e-11 in 36,000
# random loops.
_OF_RULES = 5e-11


def roundoff_error(ellipses: Ellipses, work: Array) -> Array:
    """Error of the work W pi E*/(2 f^2) that the last digits of loads and angles leave, (m,), from
    above.

    u and v, the amplitudes of (Q -+ f P)/f, are differences of Q1/f and P1. Where these are small,
    or the angles D and pi - D of the phases of slip, as many digits are lost. `work` (m,) is that
    value.
    """
    loop_size = ellipses.load_amplitude + (ellipses.u + ellipses.v) / 2
    least_swing = np.minimum(ellipses.u, ellipses.v)
    least_angle = np.minimum(ellipses.slip_angle, math.pi - ellipses.slip_angle)
    # Nothing slips where one of them is 0.
    lost_by_size = loop_size / np.where(least_swing > _TINY * loop_size, least_swing, np.inf)
    lost_by_angle = math.pi / np.where(least_angle > _TINY, least_angle, np.inf)
    # Where a difference has no digit left W may be anything that so small a slip dissipates.
    least_slip = _DIGITS * loop_size
    relative_error = _RELATIVE + _DIGITS * (lost_by_size + lost_by_angle)
    return relative_error * np.abs(work) + least_slip * least_slip


def digits_of_loop(ellipses: Ellipses) -> Array:
    """Relative error of the friction work W of each load loop, (m,), from above, that the last
    digits of its loads and angles leave where all else is exact.

    W goes as a power of the amplitudes u and v of (Q -+ f P)/f, three where slip is small. u is the
    difference of Q1/f and P1 where the loads are nearly in phase. Where the phase is near pi,
    sin(phase) has only the digits of pi - phase.
    """
    loop_size = ellipses.load_amplitude + (ellipses.u + ellipses.v) / 2
    least_swing = np.minimum(ellipses.u, ellipses.v)
    across_axis = ellipses.u * ellipses.sine_of_start
    along_axis = ellipses.u * ellipses.cosine_of_start + ellipses.load_amplitude
    axis_ratio = -along_axis / np.where(across_axis > _TINY * loop_size, across_axis, np.inf)
    lost_by_phase = np.where(along_axis < 0, axis_ratio, 0.0)
    lost_by_size = loop_size / np.where(least_swing > _TINY * loop_size, least_swing, np.inf)
    return _OF_LOOP * _DIGITS * (1 + lost_by_size + math.pi * lost_by_phase)


def works_over_time(ellipses: Ellipses, contact: Contact) -> tuple[Array, Array]:
    """Friction work of forward slip and of reverse slip in each steady ellipse, times pi E*/(2
    f^2), (m,) each, with all digits even where next to nothing slips. Takes 1 ms and more each.

    Integrated over the time of slip, cut where an edge passes a corner of the profile. Next to
    singular ends the rule is graded; parts that have not converged are halved. NaN where that does
    not help.

    At constant P and Q between -k f P and k f P the sum is 2 P^2 [(1 - k) ln(1 - k) + k - k^2/2].

    >>> from semi_analytic.hertz import HertzContact
    >>> loop = ellipses_of(
    ...     *(np.array([value]) for value in (1.0, 0.0, 0.3, math.pi / 2, 0.5))
    ... )  # k = 0.6
    >>> forward, reverse = works_over_time(
    ...     loop, HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    ... )
    >>> round(float(forward[0] + reverse[0]), 12), round(2 * (0.4 * math.log(0.4) + 0.6 - 0.18), 12)
    (0.106967414501, 0.106967414501)
    """
    forward, reverse, _ = _over_phases(
        ellipses, contact, contact.dissipation_kernel, _GRADED, _CONVERGED
    )
    return forward, reverse


# Share of the mean load below which a load at the stick edge is taken for that share: W changes by
# 1e-13 of A f^2 P0^2. Octaves by which the tables of members differ, so that the next block or call
# finds its own.
LEAST_LOAD = 2.0**-48
_STEP_OF_TABLES = 8
# Nothing that rounds differently leaves a table.
_MARGIN = 1e-12


def by_largest_load(ellipses: Ellipses) -> Iterator[tuple[Indices, int, int]]:
    """Groups of ellipses whose loads one table of ln a(P) can serve: indices of each group, and the
    first and last octave of its loads, all within [2^first, 2^(last + 1)).

    Largest loads of a group lie within eight octaves. Which table an ellipse gets follows from its
    own loads alone, whoever else is in the array. Loads below 2^-48 of the mean count as that.
    """
    largest_load = (ellipses.mean_load + ellipses.load_amplitude) * (1 + _MARGIN)
    least_load = np.maximum(ellipses.permanent_stick_load, LEAST_LOAD * ellipses.mean_load) * (
        1 - _MARGIN
    )
    group = (np.frexp(largest_load)[1] - 1) // _STEP_OF_TABLES
    first_table = (np.frexp(least_load)[1] - 1) // _STEP_OF_TABLES
    for group_number in np.unique(group).tolist():
        ellipses_of_group = np.flatnonzero(group == group_number)
        lowest_table = int(np.min(first_table[ellipses_of_group]))
        yield (
            ellipses_of_group,
            lowest_table * _STEP_OF_TABLES,
            (group_number + 1) * _STEP_OF_TABLES - 1,
        )


def dissipation_of(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """Friction work of forward and of reverse slip in each steady ellipse, for any profile, times
    pi E*/(2 f^2), (2, m), to ten digits; NaN where the quadrature does not converge.

    `contact` is the normal contact P(a) of the profile. Few nodes are taken between corners of the
    profile. Where slip is no small share of P0, ln a(P) is looked up in a series.

    >>> from semi_analytic.hertz import HertzContact
    >>> from semi_analytic.steady_ellipse import ellipses_of
    >>> loop = ellipses_of(
    ...     *(np.array([value]) for value in (1.0, 0.0, 0.3, math.pi / 2, 0.5))
    ... )  # constant P, Q1 = 0.6 f P
    >>> works = dissipation_of(loop, HertzContact(modulus=1.0, radius=1.0, datum_length=1.0))
    >>> (
    ...     round(float(works.sum()), 9),
    ...     round(2 * (0.4 * math.log(0.4) + 0.6 - 0.18), 9),
    ... )  # theory, constant load
    (0.106967415, 0.106967415)
    """
    return dissipation_and_error(ellipses, contact)[:2]


def dissipation_and_error(e: Ellipses, contact: SymmetricContact) -> Array:
    """Forward and reverse part of W pi E*/(2 f^2) of m ellipses on any profile, and the error of
    their sum from above, (3, m); NaN where the quadrature does not converge.
    """
    works = np.empty((3, len(e.mean_load)))
    for members, first_load, last_load in by_largest_load(e):
        works[:, members] = _dissipation_of_group(e.take(members), contact, first_load, last_load)
    total = works[0] + works[1]
    works[2] += roundoff_error(e, total) + contact.noise * np.abs(total)
    return works


def _dissipation_of_group(
    ellipses: Ellipses, contact: SymmetricContact, first_octave: int, last_octave: int
) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), and the error of their sum
    from above, (3, m), of ellipses whose loads lie between 2^`first_octave` and 2^(`last_octave` +
    1).

    Three methods by the largest load P - P_c of the slip zones over P0. Deep slip: integrals over
    the loads P and P_c. Shallow slip: a table of ln a. The least slip: the kernel Lam = int
    ln(a(eta)/a(P_c)) d eta itself, slow but with all digits.
    """
    works = np.empty((3, len(ellipses.mean_load)))
    deepest_share = ellipses.deepest_slip / ellipses.mean_load
    kernel = contact.dissipation_kernel
    is_deep = deepest_share > _DEEP
    is_by_series = np.zeros(len(deepest_share), dtype=bool)
    edge_loads = contact.break_loads
    log_half_width = _log_of(contact)
    table = None
    if len(ellipses.mean_load) > _DIRECT and np.any(deepest_share > _SHALLOW):
        table = _log_half_width(contact, first_octave, last_octave + 1)
        edge_loads = table.edges
        log_half_width = table
        is_by_series = (deepest_share > _SHALLOW) & ~is_deep
    is_direct = ~is_deep & ~is_by_series
    if np.any(is_direct):
        works[:, is_direct] = _over_phases(
            ellipses.take(is_direct), contact, kernel, _QUICK, _SETTLED
        )
    if table is not None and np.any(is_by_series):
        works_by_series = _over_phases(
            ellipses.take(is_by_series), contact, table.slip_area, _QUICK, _SETTLED
        )
        # Lam by series has the last digits of P - P_c times the slope of L, not of itself.
        forward, reverse, error = works_by_series
        error += _OF_SERIES / deepest_share[is_by_series] * np.abs(forward + reverse)
        works[:, is_by_series] = works_by_series
    if np.any(is_deep):
        works[:, is_deep] = _over_loads(ellipses.take(is_deep), edge_loads, log_half_width)
    return works


def _over_phases(
    ellipses: Ellipses,
    contact: Contact,
    kernel: Kernel,
    rules: tuple[PieceRule, ...],
    settled_share: float,
) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), and the error of their sum,
    (3, m), by integration over the time of each phase of slip.

    The integrand is the rate of slip force times `kernel`(P, P - P_c) = int ln(a(eta)/a(P_c)) d eta
    over P_c < eta < P, P_c the load at the stick edge. Phases are cut where an edge passes a corner
    of the profile. Each part is integrated by one of the `rules` and halved until its error is
    below `settled_share` of W.
    """
    corners = contact.break_loads
    # A corner that is nearly met counts too.
    is_above_least = corners > 0.99 * np.min(ellipses.permanent_stick_load, initial=math.inf)
    is_below_most = corners < 1.01 * np.max(
        ellipses.mean_load + ellipses.load_amplitude, initial=0.0
    )
    met_corners = corners[is_above_least & is_below_most, None]
    pieces_of_phases = []
    for phase_number, cuts in enumerate(corner_angles(ellipses, met_corners).values()):
        is_long = np.diff(cuts, axis=0) > 1e-14 * cuts[-1]
        ellipse_of_part, number_of_cut = np.nonzero(
            is_long.T & (ellipses.deepest_slip > 0)[:, None]
        )
        begin_angle = cuts[number_of_cut, ellipse_of_part]
        end_angle = cuts[number_of_cut + 1, ellipse_of_part]
        rule_number = np.minimum(
            end_angle - begin_angle < cuts[-1, ellipse_of_part], len(rules) - 1
        )
        pieces_of_phases.append(
            Pieces.of_group(phase_number, ellipse_of_part, begin_angle, end_angle, rule_number)
        )

    def work_rate(phase: Indices, ellipse_of_part: Indices, angle_in_phase: Array) -> Array:
        rate, slipped, load = np.empty((3, *angle_in_phase.shape))
        for phase_number, name in enumerate(PHASES):
            columns = slice(*np.searchsorted(phase, [phase_number, phase_number + 1]))
            rate[:, columns], slipped[:, columns], load[:, columns] = phase_of(
                name, ellipses.take(ellipse_of_part[columns]), angle_in_phase[:, columns]
            )
        return rate * kernel(load, np.minimum(slipped, load))

    pieces = Pieces.together(pieces_of_phases)
    works_of_phases, error = _over_pieces(
        ellipses, pieces, len(PHASES), work_rate, rules, settled_share
    )
    reverse, work_later, work_early = works_of_phases
    return np.stack([work_later + work_early, reverse, error])


_COURSES = ("P, E-G", "P, I-M", "P_c, E-G", "P_c, I-J", "P_c, J-M")


def _over_loads(
    ellipses: Ellipses, edge_loads: Array, log_half_width: Callable[[Array], Array]
) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), and the error of their sum,
    (3, m), by integration over loads instead of over time.

    By parts W is a sum of integrals of `log_half_width` = ln a over P and over P_c, the load at the
    stick edge. A course is one of these loads through one phase of slip. Courses are cut at the
    `edge_loads` behind which ln a is smooth.

    Angles are t along P; along P_c in phase I-J 2 t_I - t, where P_c is P at that time, D - s in
    E-G and s in J-M. s is the angle from the begin of a phase, D the angle from E to G.
    """
    # L counts from that of P0: what is left of any constant is round-off.
    log_at_mean = log_half_width(ellipses.mean_load[None])[0]

    def weighted_log(course: Indices, ellipse_of_part: Indices, angle: Array) -> Array:
        weight, load = np.empty((2, *angle.shape))
        for course_number, name in enumerate(_COURSES):
            columns = slice(*np.searchsorted(course, [course_number, course_number + 1]))
            weight[:, columns], load[:, columns] = course_of(
                name, ellipses.take(ellipse_of_part[columns]), angle[:, columns]
            )
        return weight * (log_half_width(load) - log_at_mean[ellipse_of_part])

    pieces = _pieces_of_courses(ellipses, edge_loads)
    works_of_courses, error = _over_pieces(
        ellipses, pieces, len(_COURSES), weighted_log, _BEHIND, _SETTLED, _ENOUGH
    )
    load_in_reverse, load_in_forward, edge_in_reverse, edge_early, edge_later = works_of_courses
    error += _DIGITS * np.square(ellipses.mean_load + ellipses.load_amplitude)
    forward = load_in_forward + edge_early + edge_later
    return np.stack([forward, load_in_reverse + edge_in_reverse, error])


def _pieces_of_courses(ellipses: Ellipses, edge_loads: Array) -> Pieces:
    """Ranges of angles for the integrals over P and over P_c, the load at the stick edge, cut where
    the load is one of the `edge_loads` (n,).

    A course is P or P_c through one phase of slip. In this order: P in E-G (reverse slip), P in I-M
    (forward slip), P_c in E-G, in I-J and in J-M. A piece begins at its lower load, and is also cut
    at the largest and at the least load.
    """
    is_met = (edge_loads > 0.99 * np.min(ellipses.permanent_stick_load)) & (
        edge_loads < np.max(ellipses.mean_load + ellipses.load_amplitude)
    )
    edge_loads = edge_loads[is_met, None]
    start = ellipses.slip_start
    full_turn = 2 * math.pi
    cosine_at_edge = (edge_loads - ellipses.mean_load) / np.where(
        ellipses.load_moves, ellipses.load_amplitude, np.inf
    )
    angle_at_edge = np.arccos(np.clip(cosine_at_edge, -1.0, 1.0))
    stick_edge_angle_by_v, stick_edge_angle_by_u = _stick_edge_angles(ellipses, edge_loads)
    # The greatest and the least load too: a piece has one end that is the lower load.
    zero_angles = np.zeros(len(start))
    least_angle = np.full((1, len(start)), math.pi)
    largest_angle = np.full((1, len(start)), full_turn)
    courses = (
        (
            start,
            start + ellipses.slip_angle,
            (angle_at_edge, least_angle, full_turn - angle_at_edge, largest_angle),
        ),
        (
            start + math.pi,
            start + full_turn,
            (full_turn - angle_at_edge, largest_angle, full_turn + angle_at_edge),
        ),
        (zero_angles, ellipses.slip_angle, (stick_edge_angle_by_v,)),
        (start + ellipses.slip_angle, start + math.pi, (full_turn - angle_at_edge,)),
        (zero_angles, ellipses.slip_angle, (stick_edge_angle_by_u,)),
    )
    pieces_of_courses = []
    for course_number, (begin, end, cuts) in enumerate(courses):
        unsorted_ends = np.concatenate([begin[None], *cuts, end[None]])
        ends = np.sort(np.clip(unsorted_ends, begin, np.maximum(begin, end)), axis=0)
        ellipse_of_part, number_of_cut = np.nonzero((np.diff(ends, axis=0) > 1e-14).T)
        begin_angle = ends[number_of_cut, ellipse_of_part]
        end_angle = ends[number_of_cut + 1, ellipse_of_part]
        if course_number in (0, 1, 3):
            # P grows from pi to 2 pi
            grows = (begin_angle + end_angle) / full_turn % 2 > 1
            begin_angle, end_angle = np.where(
                grows, [begin_angle, end_angle], [end_angle, begin_angle]
            )
        rule_number = np.searchsorted(_SHORT, np.abs(end_angle - begin_angle))
        pieces_of_courses.append(
            Pieces.of_group(course_number, ellipse_of_part, begin_angle, end_angle, rule_number)
        )
    return Pieces.together(pieces_of_courses)


def course_of(name: str, ellipses: Ellipses, angle: Array) -> tuple[Array, Array]:
    """Weight of ln a in the friction work W pi E*/(2 f^2) and the load, at angles along one course:
    the way of P or of P_c, the load at the stick edge, through a phase of slip.

    `name` is the load and the phase, such as "P_c, E-G". One tangent of half the angle stands for
    sine and cosine, since numpy has it in vector code.
    """
    tangent = np.tan(angle / 2)
    squared_tangent = tangent * tangent
    squared_cosine = 1 / (1 + squared_tangent)
    cosine = (1 - squared_tangent) * squared_cosine
    sine = 2 * tangent * squared_cosine
    if name == "P_c, E-G":
        return _course_of_stick_edge(
            ellipses,
            ellipses.v,
            ellipses.u,
            ellipses.slip_angle,
            squared_tangent * squared_cosine,
            cosine,
            sine,
        )
    if name == "P_c, J-M":
        return _course_of_stick_edge(
            ellipses,
            ellipses.u,
            ellipses.v,
            -ellipses.slip_angle,
            squared_tangent * squared_cosine,
            cosine,
            sine,
        )
    load = (
        ellipses.mean_load - ellipses.load_amplitude
    ) + 2 * ellipses.load_amplitude * squared_cosine
    if name == "P_c, I-J":
        along_axis = ellipses.cosine_of_start * cosine + ellipses.sine_of_start * sine
        across_axis = ellipses.cosine_of_start * sine - ellipses.sine_of_start * cosine
        weight = (1 - along_axis) * sine + 2 * ellipses.sine_of_start * across_axis * across_axis
        return -ellipses.u * ellipses.load_amplitude * weight, load
    swing = ellipses.v if name == "P, E-G" else ellipses.u
    end = ellipses.slip_start + ellipses.slip_angle if name == "P, E-G" else ellipses.slip_start
    cosine_to_end = np.cos(end) * cosine + np.sin(end) * sine
    return swing * ellipses.load_amplitude * sine * (cosine_to_end - 1), load


def _course_of_stick_edge(
    ellipses: Ellipses,
    amplitude: Array,
    other_amplitude: Array,
    turn: Array,
    half_square: Array,
    cosine: Array,
    sine: Array,
) -> tuple[Array, Array]:
    """Weight of ln a in the friction work W pi E*/(2 f^2), and the load P_c at the stick edge,
    along the course of P_c in reverse slip or in the second part of forward slip.

        P_c = P_T + `amplitude` `half_square`,
        P - P_c = `other_amplitude`/2 (1 - cos(angle - `turn`)),    `half_square` = sin^2(angle/2)

    P_T is the load at the edge of the permanent stick zone; `cosine` and `sine` are of the angle.
    """
    load_above = amplitude * half_square
    cosine_to_turn = np.cos(turn) * cosine + np.sin(turn) * sine
    slipped = other_amplitude / 2 * (1 - cosine_to_turn)
    return amplitude * sine * (load_above - slipped), ellipses.permanent_stick_load + load_above


def _over_pieces(
    ellipses: Ellipses,
    pieces: Pieces,
    n_groups: int,
    integrand: Callable[[Indices, Indices, Array], Array],
    rules: tuple[PieceRule, ...],
    settled_share: float,
    least_share: float = 0.0,
) -> tuple[Array, Array]:
    """Integrals for the friction work of each ellipse, summed by group, (n_groups, m), and their
    errors, (m,); NaN where no halving converges.

    A group is a phase of slip or a course of a load; its range of angles is given cut into pieces.
    Pieces whose checks are too large are halved and integrated again.

    Parameters
    ----------
    integrand
        of (group, ellipse, angle) arrays
    rules
        quadrature rules, of which each piece names one
    settled_share, least_share
        a piece has converged if its check is below `settled_share` W, or `least_share` P0^2 where
        that is more
    """
    n_ellipses = len(ellipses.mean_load)
    if n_ellipses < _SOME:  # every call counts, and not its length
        pieces = pieces._replace(rule=np.full(len(pieces.rule), len(rules) - 1))
        least_share = 0.0
    works_of_groups = np.zeros((n_groups, n_ellipses))
    error_of_ellipse = np.zeros(n_ellipses)
    work_size = np.zeros(n_ellipses)
    for halvings in range(_HALVINGS + 1):
        integrals, checks = _integrals(pieces, integrand, rules)
        ellipse_of_piece = pieces.member
        if not halvings:
            work_of_ellipse = np.bincount(ellipse_of_piece, integrals, n_ellipses)
            work_size = np.maximum(work_of_ellipse, least_share * np.square(ellipses.mean_load))
        is_resolved = ~(checks > settled_share * work_size[ellipse_of_piece])
        is_nothing = checks <= _NOTHING * np.square(ellipses.mean_load[ellipse_of_piece])
        is_done = is_resolved | ((halvings >= _FEW) & is_nothing)
        np.add.at(
            works_of_groups, (pieces.group[is_done], ellipse_of_piece[is_done]), integrals[is_done]
        )
        errors = checks * np.where(is_resolved, _LEFT, _ROUGHLY_LEFT)
        np.add.at(error_of_ellipse, ellipse_of_piece[is_done], errors[is_done])
        pieces = pieces.take(~is_done).halved()
        if not len(pieces.member):
            break
    works_of_groups[pieces.group, pieces.member] = np.nan
    return works_of_groups, error_of_ellipse


def _integrals(
    pieces: Pieces,
    integrand: Callable[[Indices, Indices, Array], Array],
    rules: tuple[PieceRule, ...],
) -> tuple[Array, Array]:
    """Integral over each piece, a range of angles, by the quadrature rule that it names, (n,), and
    the largest of that rule's checks of its error, (n,).

    `integrand` takes arrays of group, ellipse and angle. Pieces of one rule are taken together, as
    many as fit the cache.
    """
    integrals = np.empty(len(pieces.member))
    largest_checks = np.empty(len(pieces.member))
    for rule_number, rule in enumerate(rules):
        numbers_of_rule = np.flatnonzero(pieces.rule == rule_number)
        pieces_at_once = _ELEMENTS // len(rule.weight)
        for k in range(0, len(numbers_of_rule), pieces_at_once):
            numbers = numbers_of_rule[k : k + pieces_at_once]
            begin_angle = pieces.begin[numbers]
            end_angle = pieces.end[numbers]
            angle = (
                np.where(rule.lower, begin_angle, end_angle) + (end_angle - begin_angle) * rule.way
            )
            values_at_nodes = integrand(pieces.group[numbers], pieces.member[numbers], angle)
            length = np.abs(end_angle - begin_angle)
            integrals[numbers] = rule.weight @ values_at_nodes * length
            largest_checks[numbers] = np.max(np.abs(rule.check @ values_at_nodes), axis=0) * length
    return integrals, largest_checks


def _log_of(contact: SymmetricContact) -> Callable[[Array], Array]:
    """L of loads, ln(a/a_0) beside a flat."""
    level = replace(
        contact, datum_length=contact.least_half_width / 2 if contact.least_half_width > 0 else 0.5
    )
    return lambda load: -level.log_ratio(load)


class LogHalfWidth:
    """L = ln a of any profile by series over v = sqrt(P - P_b) behind each corner P_b; from P = 0
    on in octaves of v.

    Attributes
    ----------
    edges
        (n,) loads between which each series holds, without the first and the last
    """

    def __init__(self, contact: SymmetricContact, first_load: int, last_load: int) -> None:
        """Series of L = ln(half-width) from the load 2^first_load to 2^last_load, or to where the
        profile ends; below, L is that of 2^first_load.

        A place is a coordinate that strings the corners of the profile together. From the load P_b
        of each corner on it grows by v = sqrt(P - P_b), in which L is smooth, up to the load of the
        next corner.
        """
        corners = contact.break_loads
        largest_load = 2.0**last_load
        if contact.extent != math.inf:
            largest_load = min(largest_load, float(contact.load(contact.extent)))
        corners_inside = corners[(corners > 2.0**first_load) & (corners < largest_load)]
        corner_loads = np.array([0.0, *corners_inside, largest_load])
        corner_places = np.append(0.0, np.cumsum(np.sqrt(np.diff(corner_loads))))
        log = _log_of(contact)
        octaves = max(math.ceil(math.log2(corner_places[1]) - first_load / 2), 1)

        def log_at(place: Array) -> Array:
            corner = np.searchsorted(corner_places[1:-1], place, side="right")
            return log(corner_loads[corner] + np.square(place - corner_places[corner]))

        first_places = corner_places[1] * 2.0 ** np.arange(-octaves, 0)
        series = halved(
            log_at,
            np.append(first_places, corner_places[1:]),
            max(contact.noise / 4e-14, 1.0),
        )
        corner = np.searchsorted(corner_places[1:-1], series.edges[:-1], side="right")
        self._begin = corner_loads[corner]
        self._log = Powers(series.coefficients)
        self._first_roots = series.edges[:-1] - corner_places[corner]
        self._last_roots = series.edges[1:] - corner_places[corner]
        self.edges = (self._begin + np.square(self._first_roots))[1:]

    def _at(self, piece: Indices, v: Array) -> Array:
        """L = ln a by the series of the pieces at v = sqrt(P - P_b), P_b the corner below each."""
        first_root = self._first_roots[piece]
        place = (v - first_root) * (2 / (self._last_roots[piece] - first_root)) - 1
        return self._log(np.broadcast_to(piece, v.shape), np.clip(place, -1.0, 1.0))

    def __call__(self, load: Array) -> Array:
        """L of loads, (nodes, n); no column passes an edge."""
        piece = np.searchsorted(self.edges, load[len(load) // 2])
        return self._at(piece, np.sqrt(np.maximum(load - self._begin[piece], 0.0)))

    def slip_area(self, load: Array, slipped: Array) -> Array:
        """Lam = int [L(eta) - L(P_c)] d eta from P_c to P, L = ln a, from P = `load` and P - P_c =
        `slipped`, to 1e-16 of P - P_c: the kernel of the friction work.

        L is a series in v = sqrt(P - P_b) behind each corner P_b of the profile. The integral goes
        from series to series by Gauss' rule in v.
        """
        stick_edge_load = load - slipped
        nodes, weights = gauss(4)
        series_number = np.searchsorted(self.edges, stick_edge_load)
        last_series_number = np.searchsorted(self.edges, load)
        v = np.sqrt(np.maximum(stick_edge_load - self._begin[series_number], 0.0))
        log_at_stick_edge = self._at(series_number, v)
        integral = np.zeros(load.shape)
        load_left = slipped
        for _ in range(int(np.max(last_series_number - series_number, initial=0)) + 1):
            load_to_end_of_series = np.square(self._last_roots[series_number]) - v * v
            load_rise = np.clip(
                np.where(series_number < last_series_number, load_to_end_of_series, np.inf),
                0.0,
                load_left,
            )
            step_of_v = load_rise / np.maximum(v + np.sqrt(v * v + load_rise), 1e-300)
            v_at_nodes = v[..., None] + step_of_v[..., None] * nodes
            log_excess_at_nodes = (
                self._at(series_number[..., None], v_at_nodes) - log_at_stick_edge[..., None]
            )
            integral += step_of_v * np.sum(weights * 2 * v_at_nodes * log_excess_at_nodes, axis=-1)
            load_left = load_left - load_rise
            series_number = np.minimum(series_number + 1, last_series_number)
            v = np.where(load_left > 0, self._first_roots[series_number], v)
        return integral


@lru_cache(maxsize=8)
def _log_half_width(contact: SymmetricContact, first_load: int, last_load: int) -> LogHalfWidth:
    return LogHalfWidth(contact, first_load, last_load)


# ------------------------------------------------ Hertz, power laws, flat and rounded faces: by Lam
# Nodes of one phase at once: arrays that fit into the cache.
_NODES = 16384
# Gauss rules on [0, 1], symmetric about the middle; the last one for singularities at the ends.
_COUNTS = (12, 14, 16, 18, 20, 23, 26, 32, 42)
_RULES = (*(gauss(count) for count in _COUNTS), graded(0.0, 1.0))
_LEAST_SUMS = np.cosh(30.0 / (2 * np.array(_COUNTS)))[:, None]


def works_by_lam(
    ellipses: Ellipses,
    quick_area: Area,
    careful_area: Area,
    deep_share: float,
    least_share: float = _FLOOR,
) -> tuple[Array, Array]:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), (m,) each, for profiles
    whose kernel of the work is cheap.

    The kernel is Lam = int [ln a - ln a(P_c)] d eta from P_c to P, or a multiple of it. Each
    ellipse gets as few nodes as it needs. Ellipses of one rule and one formula for Lam are
    integrated together.

    Parameters
    ----------
    quick_area
        Lam to round-off of P - P_c, for slip beyond the share `deep_share` of P0
    careful_area
        Lam to round-off of itself, for less slip
    least_share
        no load below this share of P0 is asked for
    """
    # Where u is next to nothing, as at tangency, a phase with no slip to speak of would add
    # rounding times v.
    is_unlike = np.minimum(ellipses.u, ellipses.v) <= deep_share * np.maximum(
        ellipses.u, ellipses.v
    )
    # Members alike together: the same rule, and the same way to Lam.
    kind_of_member = 2 * _rule_of(ellipses) + (
        (ellipses.deepest_slip <= deep_share * ellipses.mean_load) | is_unlike
    )
    order_by_kind = np.argsort(kind_of_member, kind="stable")
    loops_by_kind = _rows(ellipses, least_share).take(order_by_kind, axis=1)
    sums = np.empty((3, len(order_by_kind)))
    ends_of_kinds = np.cumsum(np.bincount(kind_of_member, minlength=2 * len(_RULES)))
    # Used again and again: what is allocated once stays in the cache.
    memory = np.empty(12 * max(_NODES, 64 * len(_RULES[-1][0])))
    for kind_number in np.flatnonzero(np.diff(ends_of_kinds, prepend=0)).tolist():
        members_at_once = max(_NODES // len(_RULES[kind_number // 2][0]), 64)
        for begin in range(
            ends_of_kinds[kind_number - 1] if kind_number else 0,
            ends_of_kinds[kind_number],
            members_at_once,
        ):
            block = slice(begin, min(begin + members_at_once, ends_of_kinds[kind_number]))
            area = careful_area if kind_number % 2 else quick_area
            sums[:, order_by_kind[block]] = phase_integrals(
                loops_by_kind[:, block], _RULES[kind_number // 2], area, memory
            )
    reverse_sum, sum_later, sum_early = 2 * sums
    twice_largest_slip = 4 * ellipses.load_amplitude * ellipses.sine_of_start
    sum_early *= (
        (math.pi - ellipses.slip_angle)
        * ellipses.u
        / np.where(twice_largest_slip > _FLOOR * ellipses.mean_load, twice_largest_slip, np.inf)
    )
    return (
        sum_later * ellipses.slip_angle * ellipses.u + sum_early,
        reverse_sum * ellipses.slip_angle * ellipses.v,
    )


def lam_error(ellipses: Ellipses, work: Array, deep_share: float, log_size: Array | float) -> Array:
    """Error from above of the friction work W pi E*/(2 f^2), (m,), where its kernel Lam is taken by
    a quick or by a careful formula.

    Lam is the integral of ln a - ln a(P_c) over the loads from P_c to P. The quick formula loses
    the last digits of P L, L = ln a, as a difference.

    Parameters
    ----------
    work
        (m,) W pi E*/(2 f^2), forward and reverse slip together
    deep_share
        share of P0 that the largest P - P_c exceeds where the quick formula is taken
    log_size
        size of L = ln a, (m,) or one for all
    """
    is_unlike = np.minimum(ellipses.u, ellipses.v) <= deep_share * np.maximum(
        ellipses.u, ellipses.v
    )
    is_quick = (ellipses.deepest_slip > deep_share * ellipses.mean_load) & ~is_unlike
    last_digits = (
        _DIGITS
        * (ellipses.mean_load + ellipses.load_amplitude)
        * (ellipses.u + ellipses.v)
        * log_size
    )
    return (
        roundoff_error(ellipses, work)
        + _OF_RULES * np.abs(work)
        + np.where(is_quick, last_digits, 0.0)
    )


def _rule_of(ellipses: Ellipses) -> NDArray[np.uint8]:
    """Number of the Gauss rule in `_RULES` with the fewest nodes that is good enough for the
    friction work of each ellipse, (m,).

    # notation: P and P_c normal load and load at the edge of stick, P_T least P_c, P_min least P,
    #           P1 amplitude of P; u, v amplitudes of (Q -+ f P)/f; s angle from the begin of a
    #           phase, D length of E-G and of J-M, pi - D that of I-J; t_E time of E

    "Good enough" leaves exp(-30) of the integrals over the phases of slip (reverse E-G, forward I-J
    and J-M). It follows from where the integrands stop being analytic in the complex plane. In J-M
    and E-G the logarithm is singular where P_c = 0, at s = +-2 i arsinh(sqrt(P_T/u)) from M, and
    with v from G. Where P = 0 it is so +-2 i arsinh(sqrt(P_min/(2 P1))) beside t = pi, at s = pi -
    t_E in E-G and s = t_E in I-J; the mirror images in J-M and of I-J are farther away. Gauss' rule
    of n nodes leaves about rho^(-2 n), rho + 1/rho being the sum of the distances of the nearest
    singularity from the ends of the interval [-1, 1]. Twelve at least, since nearly without slip
    the integrand is a cube of sines.
    """
    length_of_e_to_g = np.maximum(ellipses.slip_angle, _TINY)
    length_of_i_to_j = np.maximum(math.pi - ellipses.slip_angle, _TINY)
    larger_swing = np.maximum(ellipses.u, ellipses.v)
    least_load = ellipses.mean_load - ellipses.load_amplitude
    square_at_no_stick = _square_of_imaginary(ellipses.permanent_stick_load, larger_swing)
    square_at_no_load = _square_of_imaginary(least_load, 2 * ellipses.load_amplitude)
    # Real part and squared imaginary part of singularities, each phase being the interval [-1, 1].
    # J-M is as long as E-G, and the larger of u and v serves both: one entry stands for P_c = 0 in
    # either. Which end of the interval it is beside makes no difference to the sum of distances.
    no_stick_in_slip = (-1.0, square_at_no_stick / (length_of_e_to_g * length_of_e_to_g))
    no_load_in_e_to_g = (
        2 * (math.pi - ellipses.slip_start) / length_of_e_to_g - 1,
        square_at_no_load / (length_of_e_to_g * length_of_e_to_g),
    )
    no_load_in_i_to_j = (
        2 * ellipses.slip_start / length_of_i_to_j - 1,
        square_at_no_load / (length_of_i_to_j * length_of_i_to_j),
    )
    half_sum_of_distances = np.full(len(length_of_e_to_g), np.inf)
    singularities = (no_stick_in_slip, no_load_in_e_to_g, no_load_in_i_to_j)
    for real_part, squared_imaginary_part in singularities:
        distance_from_plus_1 = np.sqrt(np.square(real_part - 1) + squared_imaginary_part)
        distance_from_minus_1 = np.sqrt(np.square(real_part + 1) + squared_imaginary_part)
        half_sum = (distance_from_plus_1 + distance_from_minus_1) / 2
        np.minimum(half_sum_of_distances, half_sum, out=half_sum_of_distances)
    return np.sum(half_sum_of_distances < _LEAST_SUMS, axis=0, dtype=np.uint8)


def _square_of_imaginary(least_load: Array, load_size: Array) -> Array:
    """Square of twice the imaginary part 2 arsinh(sqrt(least_load/load_size)) of a singularity,
    (m,): twice, since a phase of slip of length 1 is the interval [-1, 1] of length 2.
    """
    return np.square(4 * np.arcsinh(np.sqrt(least_load / np.maximum(load_size, _TINY))))


def _rows(ellipses: Ellipses, least_share: float) -> Array:
    """Angles and loads of m ellipses from which their friction work is integrated, as rows (9, m):
    h, g, P_T, P_min, u, v, alpha, beta, k.

    # notation: h half the angle from E to G, g half of that from I to J; P_T permanent stick load,
    #           P_min least load, P1 amplitude of P; u, v amplitudes of (Q -+ f P)/f; alpha =
    #           sqrt(2 P1) sin(t_E/2), beta = sqrt(2 P1) cos(t_E/2), t_E time of E; k = 4 alpha beta

    E-G is reverse slip, I-J the first part of forward slip. No load counts as less than
    `least_share` of the mean load.
    """
    phase_rows = np.empty((9, len(ellipses.mean_load)))
    phase_rows[0] = ellipses.slip_angle / 2
    phase_rows[1] = (math.pi - ellipses.slip_angle) / 2
    # A permanent or least load of 0 as the smallest load there is: the logarithm of 0 is never
    # asked for.
    np.maximum(ellipses.permanent_stick_load, least_share * ellipses.mean_load, out=phase_rows[2])
    np.maximum(
        ellipses.mean_load - ellipses.load_amplitude,
        least_share * ellipses.mean_load,
        out=phase_rows[3],
    )
    phase_rows[4] = ellipses.u
    phase_rows[5] = ellipses.v
    larger_axis = np.sqrt(ellipses.load_amplitude * (1 + np.abs(ellipses.cosine_of_start)))
    smaller_axis = (
        ellipses.load_amplitude
        * ellipses.sine_of_start
        / np.where(larger_axis > 0, larger_axis, 1.0)
    )
    cosine_is_negative = ellipses.cosine_of_start < 0
    phase_rows[6] = np.where(cosine_is_negative, larger_axis, smaller_axis)
    phase_rows[7] = np.where(cosine_is_negative, smaller_axis, larger_axis)
    phase_rows[8] = 4 * ellipses.load_amplitude * ellipses.sine_of_start
    return phase_rows


def phase_integrals(
    loops: Array, rule: tuple[Array, Array], area: Area, memory: Array
) -> tuple[Array, Array, Array]:
    """Integrals of the friction work of m ellipses over their phases of slip E-G, J-M and I-J, (m,)
    each, but for factors that are constant in a phase.

    # notation: P normal load, P_c load at the edge of stick, P_T least P_c, P_min least P, P1
    #           amplitude of P; u, v amplitudes of (Q -+ f P)/f; D angle from E to G, t_E time of E;
    #           h = D/2, g = (pi - D)/2, y node of [0, 1], nodes along axis 0, members along axis 1;
    #           alpha = sqrt(2 P1) sin(t_E/2), beta = sqrt(2 P1) cos(t_E/2), k = 4 alpha beta = 4 P1
    #           sin(t_E)

    With S = sin(h y), C = cos(h y) at the nodes and a bar for the node 1 - y, which is one of the
    same rule:

        E-G  s = D (1 - y)   rate 2 f v S C   P_c = P_T + v S^2
                                              P - P_c = u S-bar^2
        J-M  s = D y         rate 2 f u S C   P_c = P_T + u S^2
                                              P - P_c = v S-bar^2 + k S C
        I-J  s = 2 g y       rate 2 f u s c   P_c = P_min + (alpha c - beta s)^2
                                              P - P_c = k s c,   s, c = sin, cos (g y)

    The integrand is `area` times S C in E-G and J-M, times P - P_c in I-J. No difference is taken
    but one that is squared. One tangent a node stands for sine and cosine: numpy has it in vector
    code.

    Parameters
    ----------
    loops
        (9, m) rows h, g, P_T, P_min, u, v, alpha, beta, k
    rule
        nodes y on [0, 1], symmetric about 1/2, and weights, (n,) each
    area
        a multiple of Lam, the integral of ln a - ln a(P_c) over the loads from P_c to P, from P_c
        and P - P_c, (phases, n, m) each
    memory
        numbers to work in, 12 n m at least: what is allocated once stays in the cache
    """
    nodes, weights = rule
    h, g, permanent_load, least_load, u, v, alpha, beta, k = loops
    shape = (4, 3, len(nodes), len(h))
    stick_edge_loads, slipped, work_arrays, area_memory = memory[: math.prod(shape)].reshape(shape)
    stick_load_of_e_to_g, stick_load_of_j_to_m, stick_load_of_i_to_j = stick_edge_loads
    slipped_of_e_to_g, slipped_of_j_to_m, slipped_of_i_to_j = slipped
    tangent, sine_cosine, squared_secant = work_arrays

    # E-G and J-M
    _fill_tangent(nodes, h, tangent, squared_secant)
    np.divide(tangent, squared_secant, out=sine_cosine)
    squared_sine = tangent  # in the same memory
    squared_sine *= sine_cosine
    np.multiply(squared_sine, v, out=stick_load_of_e_to_g)
    np.multiply(squared_sine, u, out=stick_load_of_j_to_m)
    slipped_of_e_to_g[:] = stick_load_of_j_to_m[::-1]
    np.multiply(sine_cosine, k, out=slipped_of_j_to_m)
    slipped_of_j_to_m += stick_load_of_e_to_g[::-1]
    stick_edge_loads[:2] += permanent_load

    # I-J: (alpha c - beta s)^2 is (alpha - beta tan)^2 c^2
    _fill_tangent(nodes, g, tangent, squared_secant)
    np.divide(tangent, squared_secant, out=slipped_of_i_to_j)
    slipped_of_i_to_j *= k
    squared_difference = tangent  # in the same memory
    squared_difference *= beta
    np.subtract(alpha, squared_difference, out=squared_difference)
    squared_difference *= squared_difference
    np.divide(squared_difference, squared_secant, out=stick_load_of_i_to_j)
    stick_load_of_i_to_j += least_load

    integrand = area(stick_edge_loads, slipped, area_memory)
    integrand[:2] *= sine_cosine
    integrand[2] *= slipped_of_i_to_j
    return weights @ integrand[0], weights @ integrand[1], weights @ integrand[2]


def _fill_tangent(nodes: Array, angle: Array, tangent: Array, squared_secant: Array) -> None:
    """Write tan(angle y) and 1 + tan^2(angle y) into two arrays (n, m), for nodes y (n,) of [0, 1]
    and angles (m,).
    """
    np.multiply(nodes[:, None], angle, out=tangent)
    np.tan(tangent, out=tangent)
    np.multiply(tangent, tangent, out=squared_secant)
    squared_secant += 1


def quick_bracket(stick_edge_load: Array, slipped: Array, free: Array) -> Array:
    """P ln(P/P_c) - P + P_c from P_c = `stick_edge_load` and P - P_c = `slipped`, to round-off of P
    - P_c: the kernel n Lam of the friction work of a profile |x|^n, 2 Lam of Hertz.

    Returned in the array `free`; `stick_edge_load` is overwritten.
    """
    np.divide(slipped, stick_edge_load, out=free)
    np.log1p(free, out=free)
    load = stick_edge_load  # in the same memory
    load += slipped
    free *= load
    free -= slipped
    return free


def careful_bracket(stick_edge_load: Array, slipped: Array, free: Array) -> Array:
    """P ln(P/P_c) - P + P_c from P_c = `stick_edge_load` and P - P_c = `slipped`, to round-off of
    itself: the kernel n Lam of the friction work of a profile |x|^n, 2 Lam of Hertz.

    `stick_edge_load` is overwritten; `free` memory is not used.
    """
    del free
    load = stick_edge_load  # in the same memory
    load += slipped
    return load * log_excess(slipped / load)


_CELL_BITS = 4
_CELLS = 1 << _CELL_BITS
_REST = np.int64((1 << (52 - _CELL_BITS)) - 1)
_ONE = np.int64(1023 << 52)
# Of the Chebyshev series through twelve points eight terms leave 1e-16; as powers of half its
# argument.
_PLACES = np.cos(math.pi * (np.arange(12) + 0.5) / 12)
_TERMS = 8
_SERIES = [
    np.pad(chebyshev.cheb2poly(row[: k + 1]), (0, _TERMS - 1 - k))
    for k, row in enumerate(np.eye(_TERMS))
]
_TO_POWERS = 2.0 ** np.arange(_TERMS)[:, None] * (
    np.transpose(_SERIES) @ np.linalg.inv(chebyshev.chebvander(_PLACES, 11))[:_TERMS]
)
_NEAR_RULE = tuple(
    (float(node), float(weight * (1 - node))) for node, weight in zip(*gauss(7), strict=True)
)


class LamTable:
    """Lam, the integral of ln a - ln a(P_c) over the loads from P_c to P, of a flat and rounded
    face: polynomials in P on sixteen cells of every octave between two loads.

        Lam(P, P_c) = J(P) - J(P_c) - (P - P_c) L(P_c),     J = int_0^P L d eta, L = ln a = dJ/dP
        where P_c is close to P:  (P - P_c)^2 int_0^1 (1 - z) L'(P_c + z (P - P_c)) dz

    The number of a cell is that of the leading bits of the load, so that there is no search. To
    1e-13. `largest` is the largest L.
    """

    def __init__(self, contact: Contact, first_load: int, last_load: int) -> None:
        """Tabulate J = int_0^P ln a d eta, L = ln a and dL/dP of a contact as polynomials in P, on
        equal cells of each octave of loads from 2^first_load to 2^(last_load + 1).

        dL/dP serves two loads close together, where differences of J and L lose digits. `contact`
        is that of a flat and rounded face.
        """
        self._first = (1023 + first_load) << _CELL_BITS
        octave, cell = (grid.ravel() for grid in np.mgrid[first_load : last_load + 1, :_CELLS])
        load = np.ldexp(1 + (cell[:, None] + (1 + _PLACES) / 2) / _CELLS, octave[:, None])
        # L = ln(a/b) keeps its digits beside the flat
        contact = replace(contact, datum_length=contact.least_half_width / 2)
        integral_of_log = -contact.log_distance(load)
        log_half_width = -contact.log_ratio(load)
        # Of a short step about the load Lam is half of its square times L', but for a share of
        # 3e-14.
        load_step = 1e-6 * load
        with np.errstate(all="ignore"):
            slope_of_log = (
                2
                * contact.dissipation_kernel(load + load_step * (2 / 3), load_step)
                / (load_step * load_step)
            )
        self.largest = float(np.max(log_half_width))
        self._area = _TO_POWERS @ integral_of_log.T
        self._log = _TO_POWERS @ log_half_width.T
        self._rate = _TO_POWERS @ slope_of_log.T

    def _place(self, load: Array) -> tuple[NDArray[np.int64], Array]:
        """Number of the cell of the table in which each load lies, and its place in the cell, -1/2
        to 1/2, from the bits of the floating-point number.
        """
        bits = load.view(np.int64)
        fraction = bits & _REST
        fraction <<= _CELL_BITS
        fraction |= _ONE
        cell = bits >> (52 - _CELL_BITS)
        cell -= self._first
        if cell.size and (cell.min() < 0 or cell.max() >= self._area.shape[1]):
            raise AssertionError("a load outside the table of Lam")
        return cell, fraction.view(np.float64) - 1.5

    def quick(self, stick_edge_load: Array, slipped: Array, free: Array) -> Array:
        """Lam = int ln(a(eta)/a(P_c)) d eta from P_c = `stick_edge_load` and P - P_c = `slipped`,
        (phases, n, m), to some 1e-16 of P^2 over P - P_c; returned in the array `free`.
        """
        # one phase after the other: it stays in the cache
        for edge_load, slipped_load, lam in zip(stick_edge_load, slipped, free, strict=True):
            cell, fraction = self._place(np.stack([edge_load + slipped_load, edge_load]))
            integral_to_load, integral_to_edge = _series(self._area, cell, fraction)
            integral_to_load -= integral_to_edge
            np.multiply(slipped_load, _series(self._log, cell[1], fraction[1]), out=lam)
            np.subtract(integral_to_load, lam, out=lam)
        return free

    def careful(self, stick_edge_load: Array, slipped: Array, free: Array) -> Array:
        """Lam = int ln(a(eta)/a(P_c)) d eta from P_c = `stick_edge_load` and P - P_c = `slipped`,
        (phases, n, m), to 1e-13 of itself.

        Close loads take the integral of the tabulated slope of ln a; others the difference by
        `quick`.
        """
        integral_of_slope = np.zeros(stick_edge_load.shape)
        for node, weight in _NEAR_RULE:
            integral_of_slope += weight * _series(
                self._rate, *self._place(stick_edge_load + node * slipped)
            )
        return np.where(
            0.7 * slipped < 0.3 * stick_edge_load,
            integral_of_slope * slipped * slipped,
            self.quick(stick_edge_load, slipped, free),
        )


def _series(rows: Array, cell: NDArray[np.int64], fraction: Array) -> Array:
    """Polynomials, rows from the lowest power on, columns for the cells, all of which are columns
    of the table.
    """
    total = rows[-1].take(cell, mode="clip")
    row = np.empty(cell.shape)
    for coefficients in rows[-2::-1]:
        total *= fraction
        total += coefficients.take(cell, mode="clip", out=row)
    return total
