"""The steady cycle of loads in phase, P, Q, bulk strain and tilt back and forth on one line: its
friction work W, the density W(x) and the stick zone, in closed form but for quadrature.

# notation: A = 2/E*; eps bulk strain, alpha tilt; N = f P - d Q, a = f alpha - d eps with d = +1 in
#           forward and -1 in reverse slip; I(N, a) frictionless contact of the profile under load N
#           and tilt a; m, c its middle and half-width; s slip

On the stroke from a turning point 1 both ends slip in direction d while N falls. f p - d q is the
pressure of a frictionless contact, since bulk stress acts on the shear as tilt does on the
pressure. The stick zone, and the slip outside it, follow from the changes of N and a since point 1,

    stick zone = I(P_1 + (N - N_1)/2f, alpha_1 + (a - a_1)/2f)
    d ds = -dN (A/pi) arccosh(|x - m|/c) + da sgn(x - m) sqrt((x - m)^2 - c^2)

and W(x) is the sum of int f p |ds| over both strokes. This holds while the stick zone recedes at
both ends, |da/dN| <= A/(pi c), so that both slip the same way (Andresen, Hills and Moore, 2019).
The shear and the slip that the initial loading has left cannot be found from the cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scenes import Scene
from scenes.array_types import Array
from semi_analytic.bulk_and_tilt import LoadSizes, cycle_samples
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import convex_profile
from semi_analytic.tilted_profile import ConvexProfile

# Gauss nodes over a stroke and over a slip zone; half as many give the error.
STROKE_NODE_COUNT = 48
# Fractions u of a stroke between which an edge of the slip zone is looked for that passes a point,
# and bisections between two of them: to the last digit.
_SAMPLED_STROKE_FRACTIONS = np.linspace(0, 1, 129)
_BISECTIONS_OF_CROSSING = 46
# Round-off, relative: of slip rates against their direction, and of the fraction u.
_ROUND_OFF_SHARE = 1e-12


def _end_root_quadrature(n_nodes: int) -> tuple[Array, Array]:
    """Nodes sin(theta/2)^2 on [0, 1] and weights, (n_nodes,) each, by Gauss' rule in theta: exact
    to high order for integrands with square roots at both ends.
    """
    nodes, weights = np.polynomial.legendre.leggauss(n_nodes)
    theta = np.pi * (1 + nodes) / 2
    return np.sin(theta / 2) ** 2, np.pi / 4 * weights * np.sin(theta)


@dataclass(frozen=True, eq=False)
class Stroke:
    """The stroke from one turning point of the loads to the other, with slip in one direction; u in
    [0, 1] is the fraction of it that is done.

    Attributes
    ----------
    shape, compliance, friction
        the profile, A = 2/E*, f
    loads_at_begin, load_changes
        (4,) P, Q, bulk strain eps and tilt alpha at its begin, and their changes over the stroke
    direction
        d of slip: +1 forward, -1 in reverse
    """

    shape: ConvexProfile
    compliance: float
    friction: float
    loads_at_begin: Array
    load_changes: Array
    direction: int

    @cached_property
    def equivalent_load_and_tilt_rates(self) -> tuple[float, float]:
        """dN/du and da/du of N = f P - d Q and a = f alpha - d eps, constant over the stroke: alpha
        tilt, eps bulk strain, d direction of slip, u fraction of the stroke that is done.
        """
        load, force, strain, tilt = self.load_changes.tolist()
        return (
            self.friction * load - self.direction * force,
            self.friction * tilt - self.direction * strain,
        )

    def load_and_tilt(self, u: Array) -> tuple[Array, Array]:
        """P and tilt alpha of the contact at fractions u of the stroke, arrays like u."""
        return self.loads_at_begin[0] + u * self.load_changes[0], self.loads_at_begin[
            3
        ] + u * self.load_changes[3]

    def equivalent_load_and_tilt_of_stick(self, u: Array) -> tuple[Array, Array]:
        """Load and tilt under which the frictionless contact would be the stick zone, at fractions
        u of the stroke, arrays like u.
        """
        # dN/du and da/du of N = f P - d Q and a = f alpha - d eps
        equivalent_load_rate, equivalent_tilt_rate = self.equivalent_load_and_tilt_rates
        load_of_stick_zone = self.loads_at_begin[0] + u * equivalent_load_rate / (2 * self.friction)
        tilt_of_stick_zone = self.loads_at_begin[3] + u * equivalent_tilt_rate / (2 * self.friction)
        return load_of_stick_zone, tilt_of_stick_zone

    def middle_and_half_width(self, load: Array, tilt: Array) -> tuple[Array, Array]:
        """Middle and half-width of the frictionless contact under a load and a tilt [length]."""
        return self.shape.contact_centre_and_half_width(self.compliance * load, tilt)

    def contact_at(self, u: Array) -> tuple[Array, Array]:
        """Middle and half-width of the contact at fractions u of the stroke [length]."""
        return self.middle_and_half_width(*self.load_and_tilt(u))

    def stick_zone(self, u: Array) -> tuple[Array, Array]:
        """Middle and half-width of the stick zone at fractions u of the stroke [length]."""
        return self.middle_and_half_width(*self.equivalent_load_and_tilt_of_stick(u))

    def friction_power(self, x: Array, u: Array) -> Array:
        """Rate of the friction work per area by the fraction u of the stroke, f p |ds/du|, at
        points x in the slip zone and fractions u, arrays that broadcast [energy per area].

        f is the friction, p the pressure, s the slip; `compliance` is A = 2/E*.
        """
        contact_middle, contact_half_width = self.contact_at(u)
        pressure = self.shape.pressure(x, contact_middle, contact_half_width) / (
            math.pi * self.compliance
        )
        return np.asarray(self.friction * pressure * self.slip_rate(x, u))

    def slip_rate(self, x: Array, u: Array) -> Array:
        """Rate of slip, ds/du times the direction d, at points x outside the stick zone and
        fractions u of the stroke, arrays that broadcast [length]; positive where slip goes in the
        direction d.

            -dN/du (A/pi) arccosh(|x - m|/c) + da/du sgn(x - m) sqrt((x - m)^2 - c^2)

        m and c are the middle and the half-width of the stick zone, A = 2/E* is the `compliance`.
        N = f P - d Q and a = f alpha - d eps, alpha the tilt, eps the bulk strain.
        """
        stick_middle, stick_half_width = self.stick_zone(u)
        # dN/du and da/du
        equivalent_load_rate, equivalent_tilt_rate = self.equivalent_load_and_tilt_rates
        distance_from_middle = np.maximum(np.abs(x - stick_middle), stick_half_width)
        sqrt_of_square_difference = np.sqrt(
            (distance_from_middle - stick_half_width) * (distance_from_middle + stick_half_width)
        )
        return (
            -equivalent_load_rate
            * self.compliance
            / math.pi
            * np.arcsinh(sqrt_of_square_difference / stick_half_width)
            + equivalent_tilt_rate * np.sign(x - stick_middle) * sqrt_of_square_difference
        )

    def stick_zone_recedes(self) -> bool:
        """Whether the closed form of the stick zone holds all along this stroke. It holds if the
        stick zone lies inside the contact and recedes at both ends, and all points outside it slip
        in the direction d.

        It recedes at both ends where |da/dN| <= A/(pi c), c its half-width, A = 2/E*. N = f P - d Q
        and a = f alpha - d eps, alpha the tilt, eps the bulk strain.
        """
        # dN/du and da/du, u the fraction of the stroke
        equivalent_load_rate, equivalent_tilt_rate = self.equivalent_load_and_tilt_rates
        # middle and half-width at 129 fractions u of the stroke
        stick_middle, stick_half_width = self.stick_zone(_SAMPLED_STROKE_FRACTIONS)
        contact_middle, contact_half_width = self.contact_at(_SAMPLED_STROKE_FRACTIONS)
        # the stick zone exists and shrinks
        if equivalent_load_rate >= 0 or np.min(stick_half_width) <= 0:
            return False
        if (
            np.pi * np.max(stick_half_width) * abs(equivalent_tilt_rate)
            > -equivalent_load_rate * self.compliance
        ):
            return False

        # it lies inside the contact, but for 1e-12 of its half-width
        length_roundoff = _ROUND_OFF_SHARE * np.max(contact_half_width)
        is_left_end_inside = np.all(
            contact_middle - contact_half_width <= stick_middle - stick_half_width + length_roundoff
        )
        is_right_end_inside = np.all(
            stick_middle + stick_half_width <= contact_middle + contact_half_width + length_roundoff
        )
        if not (is_left_end_inside and is_right_end_inside):
            return False

        # points at the edges of contact slip in the direction d
        least_slip_rate = equivalent_load_rate * self.compliance * _ROUND_OFF_SHARE
        rates_at_edges = [
            self.slip_rate(
                contact_middle + sign_of_side * contact_half_width, _SAMPLED_STROKE_FRACTIONS
            )
            for sign_of_side in (-1, 1)
        ]
        return all(bool(np.min(slip_rates) >= least_slip_rate) for slip_rates in rates_at_edges)

    def work(self, n_nodes: int = STROKE_NODE_COUNT) -> float:
        """Friction work of this stroke, from one turning point of the loads to the other: the
        integral of f p |ds| over both slip zones and the stroke [energy per thickness].

        f is the friction, p the pressure, s the slip. `n_nodes` nodes are taken along x and along
        the stroke; they suit square roots at both ends. A slip zone lies on each side of the stick
        zone, up to the edge of contact.
        """
        nodes, weights = _end_root_quadrature(n_nodes)
        stroke_fraction = nodes[:, None]  # rows are instants, columns points
        stick_middle, stick_half_width = self.stick_zone(stroke_fraction)
        contact_middle, contact_half_width = self.contact_at(stroke_fraction)
        total_work = 0.0
        for sign_of_side in (-1, 1):
            zone_begin = stick_middle + sign_of_side * stick_half_width
            zone_length = contact_middle + sign_of_side * contact_half_width - zone_begin
            # f p |ds/du|
            friction_power = self.friction_power(zone_begin + zone_length * nodes, stroke_fraction)
            total_work += float(weights @ (np.abs(zone_length) * friction_power) @ weights)
        return total_work

    def displacement_and_moment_change(self, u: Array) -> Array:
        """Change of the tangential displacement U [length] and of the moment m_q of the shear since
        the stroke began, (2, n), at fractions u (n,) of the stroke; m_q = int x q dx.

        With the normal approach h and the moment m_p = int x p dx of a frictionless contact,

            U - U_1 = d f [h - 2 h_s + h_1],    m_q - m_q1 = d f [m_p - 2 m_ps + m_p1]

        1 is the begin of the stroke. Index s is the contact that would be the stick zone, d the
        direction of slip, p the pressure; `compliance` is A = 2/E*.
        """

        def approach_and_moment(load: Array, tilt: Array) -> Array:
            """Normal approach h and moment m_p of the frictionless contact, (2, n)."""
            middle, half_width = self.middle_and_half_width(load, tilt)
            approach = self.shape.approach(
                middle, half_width, tilt
            ) + self.compliance * load / math.pi * np.log(2 / half_width)
            return np.stack(
                [approach, self.shape.moment(middle, half_width, tilt) / self.compliance]
            )

        # rows: approach and moment of the pressure
        values_at_begin = approach_and_moment(*self.load_and_tilt(np.zeros(1)))
        values_of_contact = approach_and_moment(*self.load_and_tilt(u))
        values_of_stick_zone = approach_and_moment(*self.equivalent_load_and_tilt_of_stick(u))
        change_since_begin = values_of_contact - 2 * values_of_stick_zone + values_at_begin
        return self.direction * self.friction * change_since_begin

    def work_density(self, x: Array, n_nodes: int = STROKE_NODE_COUNT) -> Array:
        """Friction work per area of this stroke at points x (k,): the integral of f p |ds| over the
        stroke, (k,) [energy per area].

        f is the coefficient of friction, p the pressure, s the slip. The stroke begins at u = 0 and
        ends at u = 1.

        At each point the stroke is divided where an edge of the slip zone passes it. Each part with
        slip takes `n_nodes` nodes. A slip zone lies on each side of the stick zone, up to the edge
        of contact.
        """
        point_of_part, begin_fraction, end_fraction = self._parts_with_slip(x)
        nodes, weights = _end_root_quadrature(n_nodes)
        part_lengths = (end_fraction - begin_fraction)[:, None]
        # f p |ds/du|
        friction_power = self.friction_power(
            x[point_of_part, None], begin_fraction[:, None] + part_lengths * nodes
        )
        density_at_points = np.bincount(
            point_of_part, (part_lengths * friction_power) @ weights, len(x)
        )
        return np.asarray(density_at_points, dtype=float)

    def _depth_in_slip_zone(self, x: Array, u: Array) -> Array:
        """Distance of points x to the nearer end of the slip zone that they lie in, positive within
        it [length], at fractions u of the stroke, arrays that broadcast.

        A slip zone lies on each side of the stick zone, up to the edge of contact.
        """
        stick_middle, stick_half_width = self.stick_zone(u)
        contact_middle, half_width = self.contact_at(u)
        return np.minimum(
            np.abs(x - stick_middle) - stick_half_width, half_width - np.abs(x - contact_middle)
        )

    def _crossings_of_points(self, x: Array) -> tuple[NDArray[np.intp], Array]:
        """Where an edge of a slip zone passes the points x (k,): number of the point, and fraction
        u of the stroke, (n,) each; by bisection between 129 fractions.
        """
        is_in_slip_zone = self._depth_in_slip_zone(x, _SAMPLED_STROKE_FRACTIONS[:, None]) > 0
        interval_of_crossing, crossed_points = np.nonzero(
            is_in_slip_zone[1:] != is_in_slip_zone[:-1]
        )
        fraction_before = _SAMPLED_STROKE_FRACTIONS[interval_of_crossing]
        fraction_after = _SAMPLED_STROKE_FRACTIONS[interval_of_crossing + 1]
        for _ in range(_BISECTIONS_OF_CROSSING):
            middle_fraction = (fraction_before + fraction_after) / 2
            has_crossed = (
                self._depth_in_slip_zone(x[crossed_points], middle_fraction) > 0
            ) != is_in_slip_zone[interval_of_crossing, crossed_points]
            fraction_before = np.where(has_crossed, fraction_before, middle_fraction)
            fraction_after = np.where(has_crossed, middle_fraction, fraction_after)
        return crossed_points, fraction_before

    def _parts_with_slip(self, x: Array) -> tuple[NDArray[np.intp], Array, Array]:
        """Parts of the stroke in which the points x (k,) slip: number of the point, and fractions u
        of the stroke at the begin and at the end of the part, (n,) each, point by point.

        The stroke of a point is divided where an edge of a slip zone passes it.
        """
        crossed_points, fractions_of_crossings = self._crossings_of_points(x)
        all_points = np.arange(len(x))
        point_of_fraction = np.concatenate([all_points, crossed_points, all_points])
        fractions = np.concatenate([0 * x, fractions_of_crossings, 0 * x + 1])
        order_by_point = np.lexsort((fractions, point_of_fraction))
        point_of_fraction = point_of_fraction[order_by_point]
        fractions = fractions[order_by_point]
        # A part lies between two neighbouring fractions of one point.
        first_fraction_of_part = np.flatnonzero(point_of_fraction[1:] == point_of_fraction[:-1])
        middle_fractions = (
            fractions[first_fraction_of_part] + fractions[first_fraction_of_part + 1]
        ) / 2
        is_in_slip = (
            self._depth_in_slip_zone(x[point_of_fraction[first_fraction_of_part]], middle_fractions)
            > 0
        )
        first_fraction_of_part = first_fraction_of_part[is_in_slip]
        return (
            point_of_fraction[first_fraction_of_part],
            fractions[first_fraction_of_part],
            fractions[first_fraction_of_part + 1],
        )


def strokes_in_phase(scene: Scene) -> tuple[Stroke, Stroke] | None:
    """The forward and the reverse stroke of a cycle with P, Q, bulk strain and tilt in phase, and
    slip in one direction on both sides of the stick zone; None for any other cycle.

    There are none either without a cycle or without friction, and where Q rests or P reaches 0. In
    phase means that these four lie on one line between two turning points, each half of the
    cycle going along it once. Samples are (4, n): P, Q, bulk strain and tilt.
    """
    friction_coefficient = scene.friction.coefficient
    if not scene.load.path().cycle or friction_coefficient <= 0:
        return None
    # as a curve that can be tilted, and A = 2/E*
    profile = convex_profile(scene.profile)
    compliance = 2 / composite_modulus(scene.material)
    load_samples = cycle_samples(scene)
    normal_load, tangential_load = load_samples[:2]
    # of the forward stroke; the reverse one goes back
    loads_at_begin = load_samples[:, np.argmin(tangential_load)]
    loads_at_end = load_samples[:, np.argmax(tangential_load)]
    # (4,), below which a change of each of them is round-off
    load_sizes = LoadSizes.of_samples(load_samples, profile, compliance, friction_coefficient)
    _, roundoff_of_tangential_load, *_ = load_sizes.roundoff
    if loads_at_end[1] - loads_at_begin[1] <= roundoff_of_tangential_load:
        return None
    if not np.min(normal_load) > 0:
        return None
    if not _go_to_and_fro_on_line(load_samples, loads_at_begin, loads_at_end, load_sizes.roundoff):
        return None
    load_changes = loads_at_end - loads_at_begin
    strokes = (
        Stroke(profile, compliance, friction_coefficient, loads_at_begin, load_changes, 1),
        Stroke(profile, compliance, friction_coefficient, loads_at_end, -load_changes, -1),
    )
    return strokes if all(stroke.stick_zone_recedes() for stroke in strokes) else None


def _go_to_and_fro_on_line(
    load_samples: Array, loads_at_begin: Array, loads_at_end: Array, roundoff: Array
) -> bool:
    """Whether the loads of a cycle go once along the straight line between two points, and once
    back. `load_samples` (4, n) are P, Q, bulk strain and tilt in the cycle.

    `loads_at_begin` and `loads_at_end` (4,) are the points of least and of largest Q. A load is on
    the line within its `roundoff`, (4,).
    """
    load_changes = loads_at_end - loads_at_begin
    tangential_load = load_samples[1]
    fraction_of_way = (tangential_load - loads_at_begin[1]) / load_changes[1]
    deviations = np.abs(
        load_samples - loads_at_begin[:, None] - np.outer(load_changes, fraction_of_way)
    )
    is_on_line = not np.any(np.max(deviations, axis=1) > roundoff)
    # direction of each change, without those of round-off, 1e-12
    changes = np.diff(fraction_of_way, append=fraction_of_way[0])
    signs_of_changes = np.sign(changes[np.abs(changes) > _ROUND_OFF_SHARE])
    n_reversals = np.count_nonzero(signs_of_changes != np.roll(signs_of_changes, 1))
    return is_on_line and bool(n_reversals == 2)


def work_by_loads(strokes: tuple[Stroke, Stroke]) -> float:
    """Friction work of a cycle from its loads [energy per thickness]: the closed integral of Q
    dU - m_q d eps, by parts.

    U is the displacement, m_q = int x q dx the moment of the shear q, eps the bulk strain. The
    integral needs no slip: it is a second route to the same work.
    """
    # 48 nodes along a stroke
    nodes, weights = _end_root_quadrature(STROKE_NODE_COUNT)
    u = np.append(nodes, 1.0)  # fractions of a stroke, its end the last
    # U and m_q at the begin of the stroke, counted from the begin of the cycle
    values_at_begin = np.zeros((2, 1))
    loop_work = 0.0
    for stroke in strokes:
        # U and m_q along the stroke, counted from the begin of the cycle
        displacements, moments = values_at_begin + stroke.displacement_and_moment_change(u)
        # index 1: Q, 2: bulk strain
        loop_work -= weights @ (
            stroke.load_changes[1] * displacements[:-1] + stroke.load_changes[2] * moments[:-1]
        )
        values_at_begin = np.array([displacements[-1:], moments[-1:]])
    return float(loop_work)
