"""W of steady ellipses with the effects of bodies, arrays of them at once.

Of each punch the frozen force F lies between two sinusoids, the bounds B of `corrected_memory`
while the punch is in contact. It is carried along by the one that it meets and stands still in
between: a play operator, of which everything is elementary. With pi = P - eta - kn G, the load
that is carried beyond a punch,

    W = (A/pi) int w(c) dc/c,    w = closed-int f pi |dF|

Between two instants at which a bound turns round both bounds move one way, F ends at the bound that
it meets, and w has a primitive: no time steps. A punch that comes into contact starts with F where
both bounds meet; one that always is in contact starts at the end of its forward slip.

# notation: c half-width of a punch, eta and G its loads, s = +1 forward, -1 reverse slip
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from scenes.array_types import Array
from semi_analytic.corrected_memory import Curvatures
from semi_analytic.profiles import SymmetricContact

# Gauss' nodes in each of two ranges of punches. At other punches, where slip changes from one kind
# to another, w has a kink: these leave 2e-5 of W.
_NODES = 32
_SECANTS = 40
_CLOSE = 1e-13
# Share of a value at the other end below which one is round-off.
_ROUNDING = 1e-9
_TINY = float(np.finfo(float).tiny)
# Columns of members and punches that are taken at once.
_AT_ONCE = 2048


@dataclass(frozen=True, eq=False)
class EllipseOfLoads:
    """P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - phase), columns (m, 1), with their friction."""

    mean_normal: Array
    normal_amplitude: Array
    mean_tangential: Array
    tangential_amplitude: Array
    phase: Array
    friction: Array

    def take(self, members: slice) -> EllipseOfLoads:
        """Some of them."""
        return EllipseOfLoads(*(getattr(self, item.name)[members] for item in fields(self)))

    def over(self, unit: Array) -> EllipseOfLoads:
        """The same with loads in units (m, 1)."""
        return replace(
            self,
            mean_normal=self.mean_normal / unit,
            normal_amplitude=self.normal_amplitude / unit,
            mean_tangential=self.mean_tangential / unit,
            tangential_amplitude=self.tangential_amplitude / unit,
        )

    def wave(self, of_normal: Array, of_tangential: Array, constant: Array) -> _Wave:
        """`of_normal` P + `of_tangential` Q + `constant`, (m, k)."""
        amplitude = of_tangential * self.tangential_amplitude
        cosine = of_normal * self.normal_amplitude + amplitude * np.cos(self.phase)
        sine = amplitude * np.sin(self.phase)
        mean = of_normal * self.mean_normal + of_tangential * self.mean_tangential + constant
        return _Wave(mean, np.hypot(cosine, sine), np.arctan2(sine, cosine))


class BendColumns(NamedTuple):
    """N, N_Q, T, T_P of `Curvatures` for each member, (m, 1)."""

    normal: Array
    normal_under_shear: Array
    tangential: Array
    tangential_under_pressure: Array

    @classmethod
    def of(cls, bends: Curvatures, unit: Array) -> BendColumns:
        """The numbers in units of members (m, 1)."""
        return cls(
            normal=bends.normal * unit,
            normal_under_shear=bends.normal_under_shear * unit,
            tangential=bends.tangential * unit,
            tangential_under_pressure=bends.tangential_under_pressure * unit,
        )

    def take(self, members: slice) -> BendColumns:
        """Those of some members."""
        return BendColumns(*(column[members] for column in self))


class _Wave(NamedTuple):
    """mean + amplitude cos(t - phase), (m, k) each."""

    mean: Array
    amplitude: Array
    phase: Array

    def at(self, time: Array) -> Array:
        """Its values, (m, k)."""
        return np.asarray(self.mean + self.amplitude * np.cos(time - self.phase))


class Bounds(NamedTuple):
    """Of punches (m, k): B of forward slip, minus B of reverse slip, load carried beyond."""

    forward: _Wave
    reverse: _Wave
    beyond: _Wave


def bounds_of(loads: EllipseOfLoads, bends: BendColumns, eta: Array, parabola: Array) -> Bounds:
    """Waves over a steady cycle that decide what each flat punch of a contact does: the Coulomb
    bounds of forward and of reverse slip, and the normal load carried beyond it, for punches (m,
    k).

    With the curvatures kn, kt that finite bodies give to gap and faces

        s B_s = s (Q - kt G) - f (P - eta - kn G),    s = +1 forward, -1 reverse

    A punch of half-width c carries eta, `eta`, of the profile, and G = (pi E*/4) c^2, `parabola`,
    of a parabola of curvature 1. `bends` has the curvatures by which bodies change gap and faces
    per P and per Q.
    """
    f = loads.friction
    gap_by_normal = parabola * bends.normal
    gap_by_shear = parabola * bends.normal_under_shear
    faces_by_shear = parabola * bends.tangential
    faces_by_normal = parabola * bends.tangential_under_pressure
    # s B_s = s (Q - kt G) - f (P - eta - kn G)
    forward = loads.wave(
        -f * (1 - gap_by_normal) - faces_by_normal, 1 - faces_by_shear + f * gap_by_shear, f * eta
    )
    reverse = loads.wave(
        -f * (1 - gap_by_normal) + faces_by_normal, faces_by_shear - 1 + f * gap_by_shear, f * eta
    )
    beyond = loads.wave(1 - gap_by_normal, -gap_by_shear, -eta)
    return Bounds(forward, reverse, beyond)


class WorkOfEllipses(NamedTuple):
    """pi/A W of forward and of reverse slip, half-width of permanent stick, (m,) each."""

    forward: Array
    reverse: Array
    stick: Array


def works_of_ellipses(
    loads: EllipseOfLoads, bends: BendColumns, contact: SymmetricContact, modulus: float
) -> WorkOfEllipses:
    """Friction work of a steady cycle times pi/A of load ellipses (m,) on one profile with the
    curvatures of finite bodies, forward and reverse; and the half-width of permanent stick.

    NaN where the contact leaves the profile or would split. `bends` are the curvatures that the
    bodies add by P and by Q, `modulus` is the E* of `contact`, and numbers are in its units.

    >>> from semi_analytic.hertz import HertzContact
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> one, half = np.ones((1, 1)), np.full((1, 1), 0.5)
    >>> loads = EllipseOfLoads(one, 0 * one, 0 * one, half, 0 * one, one)
    >>> flat = BendColumns.of(Curvatures(), one)
    >>> work = works_of_ellipses(loads, flat, contact, 1.0)
    >>> round(float(work.forward[0] + work.reverse[0]), 5)  # -2 int (2 z - 1/2) ln(1 - z) dz
    0.05685
    """
    count = len(loads.friction)
    works_and_stick = np.empty((3, count))
    for first_member in range(0, count, _AT_ONCE):
        block = slice(first_member, first_member + _AT_ONCE)
        works_and_stick[:, block] = _works_of_some(
            loads.take(block), bends.take(block), contact, modulus
        )
    return WorkOfEllipses(*works_and_stick)


def _works_of_some(
    loads: EllipseOfLoads, bends: BendColumns, contact: SymmetricContact, modulus: float
) -> Array:
    """Friction work of forward and of reverse slip times pi/A, and the half-width of permanent
    stick, of load ellipses (m, 1) on one profile with the curvatures of finite bodies: (3, m).

    The work is the integral over the flat punches that slip, between permanent stick and the
    largest contact; each is followed through a cycle by itself. NaN where the contact would split
    or leave the profile. `bends` are the curvatures that the bodies add by P and by Q, (m, 1);
    `modulus` is E*, and A = 2/E*.
    """

    def bounds_at(half_width: Array) -> Bounds:
        eta = np.where(half_width > contact.least_half_width, contact.load(half_width), 0.0)
        return bounds_of(loads, bends, eta, math.pi * modulus / 4 * half_width**2)

    # Functions of the half-width of a punch that rise through 0 at the edge that is looked for.
    # `beyond` is the normal load carried beyond a punch, its mean and amplitude in the cycle: a
    # punch touches while it is positive.
    def open_at_all_loads(half_width: Array) -> Array:
        beyond = bounds_at(half_width).beyond
        return -(beyond.mean + beyond.amplitude)

    def open_at_least_load(half_width: Array) -> Array:
        beyond = bounds_at(half_width).beyond
        return beyond.amplitude - beyond.mean

    def bounds_overlap(half_width: Array) -> Array:
        forward_bound, reverse_bound, _ = bounds_at(half_width)
        return (
            forward_bound.mean
            + forward_bound.amplitude
            + reverse_bound.mean
            + reverse_bound.amplitude
        )

    largest_load = loads.mean_normal + loads.normal_amplitude
    search_end = np.minimum(contact.half_width(largest_load) * 2, contact.extent)
    contact_edge = _root(open_at_all_loads, np.zeros_like(search_end), search_end)
    least_contact_edge = _root(open_at_least_load, np.zeros_like(search_end), contact_edge)
    permanent_stick = np.minimum(
        _root(bounds_overlap, np.zeros_like(search_end), contact_edge), contact_edge
    )
    middle_of_zone = np.clip(least_contact_edge, permanent_stick, contact_edge)
    nodes, gauss_weights = np.polynomial.legendre.leggauss(_NODES)
    node_share = (1 + nodes) / 2
    # Nodes crowd at both ends, where slip begins like a root.
    crowded_node = node_share**2 * (3 - 2 * node_share)
    crowded_weights = gauss_weights / 2 * 6 * node_share * (1 - node_share)
    works = np.zeros((2, len(contact_edge)))
    for part_begin, part_length in (
        (permanent_stick, middle_of_zone - permanent_stick),
        (middle_of_zone, contact_edge - middle_of_zone),
    ):
        half_width = part_begin + part_length * crowded_node
        work_of_punches = _work_of_punches(bounds_at(half_width), loads.friction)
        works += np.sum(
            work_of_punches * (crowded_weights * part_length / np.maximum(half_width, _TINY)),
            axis=2,
        )
    # dP/da at the edge, with the least curvature that the bodies add.
    least_normal_load = loads.mean_normal - loads.normal_amplitude
    curvature_bound = np.minimum(
        bends.normal * np.where(bends.normal < 0, largest_load, least_normal_load), 0.0
    )
    largest_force = np.abs(loads.mean_tangential) + loads.tangential_amplitude
    curvature_bound = curvature_bound - np.abs(bends.normal_under_shear) * largest_force
    stiffness = (
        contact.stiffness(contact_edge) + math.pi * modulus / 2 * curvature_bound * contact_edge
    )
    is_refused = ~(stiffness[:, 0] > 0) | np.isnan(least_contact_edge[:, 0])
    works[:, is_refused] = np.nan
    return np.stack([*works, np.where(is_refused, np.nan, permanent_stick[:, 0])])


def _root(values: Callable[[Array], Array], lower_bound: Array, upper_bound: Array) -> Array:
    """Places at which rising functions of (m, 1) are 0, between `lower_bound` and `upper_bound`,
    (m, 1) each, by the Illinois rule: secants that keep the root between them.

    The lower bound where a function is positive there, NaN where it is negative at the upper one.
    `values` gives all functions at (m, 1) places.
    """
    value_at_lower = values(lower_bound)
    value_at_upper = values(upper_bound)
    value_scale = np.maximum(np.abs(value_at_lower), np.abs(value_at_upper))
    is_beyond = value_at_upper < -_ROUNDING * value_scale
    side_of_last = np.zeros(lower_bound.shape)
    place = lower_bound
    for _ in range(_SECANTS):
        value_difference = np.where(
            value_at_upper > value_at_lower, value_at_upper - value_at_lower, 1.0
        )
        place = np.clip(
            lower_bound - value_at_lower * (upper_bound - lower_bound) / value_difference,
            lower_bound,
            upper_bound,
        )
        value_at_place = values(place)
        if np.all(
            (np.abs(value_at_place) <= _CLOSE * value_scale) | is_beyond | (value_at_lower >= 0)
        ):
            break
        is_positive = value_at_place > 0
        value_at_lower = np.where(
            is_positive & (side_of_last > 0), value_at_lower / 2, value_at_lower
        )
        value_at_upper = np.where(
            ~is_positive & (side_of_last < 0), value_at_upper / 2, value_at_upper
        )
        upper_bound = np.where(is_positive, place, upper_bound)
        value_at_upper = np.where(is_positive, value_at_place, value_at_upper)
        lower_bound = np.where(is_positive, lower_bound, place)
        value_at_lower = np.where(is_positive, value_at_lower, value_at_place)
        side_of_last = np.where(is_positive, 1.0, -1.0)
    return np.where(is_beyond, np.nan, place)


def _work_of_punches(bounds: Bounds, friction: Array) -> Array:
    """Integral of f times the load beyond a punch over |dF| in a steady cycle, in forward and in
    reverse slip, for flat punches (m, k): (2, m, k).

    F, the tangential force that a punch locks in, follows the larger of two waves of load, the
    Coulomb `bounds`, while the load beyond the punch is positive. The cycle is cut where a wave
    turns.
    """
    forward, reverse, beyond = bounds
    full_turn = 2 * math.pi
    # In contact all the time, for a while around the phase of the load, or never.
    cosine_of_opening = np.clip(-beyond.mean / np.maximum(beyond.amplitude, _TINY), -1.0, 1.0)
    is_always = beyond.mean >= beyond.amplitude
    begin_angle = np.where(is_always, forward.phase, beyond.phase - np.arccos(cosine_of_opening))
    contact_duration = np.where(is_always, full_turn, 2 * np.arccos(cosine_of_opening))
    turning_angles = np.stack(
        [forward.phase, forward.phase + math.pi, reverse.phase, reverse.phase + math.pi]
    )
    angles_since_begin = np.minimum(
        np.mod(turning_angles - begin_angle, full_turn), contact_duration
    )
    angles_since_begin.sort(axis=0)
    force_now = forward.at(begin_angle)
    works = np.zeros((2, *begin_angle.shape))
    for time in (*(begin_angle + angles_since_begin), begin_angle + contact_duration):
        for direction, wave in ((0, forward), (1, reverse)):
            sign = 1.0 if direction == 0 else -1.0
            bound_at_end = wave.at(time)
            is_slipping = bound_at_end > sign * force_now
            primitive_at_end = _primitive(wave, beyond, bound_at_end)
            primitive_rise = primitive_at_end - _primitive(wave, beyond, sign * force_now)
            works[direction] += np.where(is_slipping, primitive_rise, 0.0)
            force_now = np.where(is_slipping, sign * bound_at_end, force_now)
    return np.asarray(friction * np.maximum(works, 0.0))


def _primitive(wave: _Wave, beyond: _Wave, bound_level: Array) -> Array:
    """Integral of the load carried beyond a punch over d(wave), up to where the rising wave has
    reached `bound_level`, (m, k), in closed form.

        A [p cos(theta) + b (cos(D) cos^2(theta)/2 - sin(D) (theta - sin(theta) cos(theta))/2)]

    The wave is at the angle theta before its maximum, A its amplitude, D its phase minus that of
    the load; p and b are mean and amplitude of the load.
    """
    amplitude = np.maximum(wave.amplitude, _TINY)
    cosine = np.clip((bound_level - wave.mean) / amplitude, -1.0, 1.0)
    sine = np.sqrt(1 - cosine**2)
    theta = np.arccos(cosine)
    lag = wave.phase - beyond.phase
    in_phase = np.cos(lag) * cosine**2
    out_of_phase = np.sin(lag) * (theta - sine * cosine)
    wave_part = beyond.amplitude * (in_phase - out_of_phase) / 2
    return np.asarray(wave.amplitude * (beyond.mean * cosine + wave_part))
