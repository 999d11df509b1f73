"""The steady cycle of loads in phase, P, Q, bulk strain and tilt there and back on one line: W,
W(x) and the stick zone, exact.

# notation: A = 2/E*; eps bulk strain, alpha tilt; N = f P - d Q, a = f alpha - d eps with d = +1 in
#           forward and -1 in reverse slip; I(N, a) frictionless contact of the profile under load N
#           and tilt a; m, c its middle and half-width

On the way from a turning point 1 both ends slip in direction d while N falls. f p - d q is the
pressure of a frictionless contact (bulk stress acts on the shear as tilt does on the pressure), and
the stick zone and the slip outside it follow from how N and a have changed since,

    stick zone = I(P_1 + (N - N_1)/2f, alpha_1 + (a - a_1)/2f)
    d ds = -dN (A/pi) arccosh(|x - m|/c) + da sgn(x - m) sqrt((x - m)^2 - c^2)

and W(x) is the sum of both ways of int f p |ds|. This holds while the stick zone recedes at both
ends, |da/dN| <= A/(pi c), so that both slip the same way (Andresen, Hills and Moore, 2019). The
shear and the slip that the initial loading has left are not known from the cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scenes import Scene
from scenes.array_types import Array
from semi_analytic.bulk_and_tilt import LoadSizes, cycle_samples
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import convex_profile
from semi_analytic.tilted_profile import ConvexProfile

# Gauss nodes over a way and over a slip zone; half as many tell the error.
WAY_NODES = 48
# Shares of a way between which the edges are looked for that pass a point, and halvings of them: to
# the last digit.
_SHARES = np.linspace(0, 1, 129)
_HALVINGS = 46
# Share by which a slip rate may be against its direction.
_ROUNDING = 1e-12


def _angles(count: int) -> tuple[Array, Array]:
    """Shares sin(theta/2)^2 of an interval and weights, for square roots at both of its ends."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    theta = np.pi * (1 + nodes) / 2
    return np.sin(theta / 2) ** 2, np.pi / 4 * weights * np.sin(theta)


@dataclass(frozen=True, eq=False)
class Way:
    """The way from one turning point to the other, with slip in one direction; u from 0 to 1 is the
    share of it that is behind.

    Attributes
    ----------
    shape, compliance, friction
        the profile, A, f
    begin, change
        (4,) P, Q, eps and alpha where it begins, and by how much they change
    direction
        d
    """

    shape: ConvexProfile
    compliance: float
    friction: float
    begin: Array
    change: Array
    direction: int

    @cached_property
    def rates(self) -> tuple[float, float]:
        """dN/du and da/du."""
        load, force, strain, tilt = self.change.tolist()
        return (
            self.friction * load - self.direction * force,
            self.friction * tilt - self.direction * strain,
        )

    def pressed(self, u: Array) -> tuple[Array, Array]:
        """Load and tilt of the contact, arrays like u."""
        return self.begin[0] + u * self.change[0], self.begin[3] + u * self.change[3]

    def stuck(self, u: Array) -> tuple[Array, Array]:
        """Load and tilt of the contact that the stick zone is, arrays like u."""
        load_rate, tilt_rate = self.rates
        load = self.begin[0] + u * load_rate / (2 * self.friction)
        tilt = self.begin[3] + u * tilt_rate / (2 * self.friction)
        return load, tilt

    def interval(self, load: Array, tilt: Array) -> tuple[Array, Array]:
        """Middle and half-width of a contact."""
        return self.shape.contact(self.compliance * load, tilt)

    def contact(self, u: Array) -> tuple[Array, Array]:
        """Middle and half-width of the contact."""
        return self.interval(*self.pressed(u))

    def stick(self, u: Array) -> tuple[Array, Array]:
        """Middle and half-width of the stick zone."""
        return self.interval(*self.stuck(u))

    def friction_power(self, x: Array, u: Array) -> Array:
        """f p |ds/du| at points in the slip zone, arrays that broadcast."""
        m, c = self.contact(u)
        pressure = self.shape.pressure(x, m, c) / (math.pi * self.compliance)
        return np.asarray(self.friction * pressure * self.slip_rate(x, u))

    def slip_rate(self, x: Array, u: Array) -> Array:
        """d ds/du >= 0 at points outside the stick zone, arrays that broadcast."""
        m, c = self.stick(u)
        load_rate, tilt_rate = self.rates
        distance = np.maximum(np.abs(x - m), c)
        root_of_squares = np.sqrt((distance - c) * (distance + c))
        return (
            -load_rate * self.compliance / math.pi * np.arcsinh(root_of_squares / c)
            + tilt_rate * np.sign(x - m) * root_of_squares
        )

    def recedes(self) -> bool:
        """Whether the stick zone recedes at both ends all along this stroke, inside the contact,
        with slip of one direction outside it: only then the solution of loads in phase holds.
        """
        load_rate, tilt_rate = self.rates
        shares_of_way = _SHARES
        stick_middle, stick_half_width = self.stick(shares_of_way)
        contact_middle, contact_half_width = self.contact(shares_of_way)
        if load_rate >= 0 or np.min(stick_half_width) <= 0:
            return False
        if np.pi * np.max(stick_half_width) * abs(tilt_rate) > -load_rate * self.compliance:
            return False
        round_off = _ROUNDING * np.max(contact_half_width)
        left_inside = np.all(
            contact_middle - contact_half_width <= stick_middle - stick_half_width + round_off
        )
        right_inside = np.all(
            stick_middle + stick_half_width <= contact_middle + contact_half_width + round_off
        )
        if not (left_inside and right_inside):
            return False
        most_negative = load_rate * self.compliance * _ROUNDING
        rates_at_edges = [
            self.slip_rate(contact_middle + side * contact_half_width, shares_of_way)
            for side in (-1, 1)
        ]
        return all(bool(np.min(slip_rates) >= most_negative) for slip_rates in rates_at_edges)

    def work(self, count: int = WAY_NODES) -> float:
        """Friction work of this stroke, from one end of the cycle to the other: the integral of f p
        |ds| over both slip zones and the stroke [energy per thickness].

        `count` nodes are taken along x and along the stroke.
        """
        nodes, weights = _angles(count)
        share_of_way = nodes[:, None]
        stick_middle, stick_half_width = self.stick(share_of_way)
        contact_middle, half_width = self.contact(share_of_way)
        total_work = 0.0
        for sign_of_side in (-1, 1):
            zone_begin = stick_middle + sign_of_side * stick_half_width
            zone_length = contact_middle + sign_of_side * half_width - zone_begin
            power = self.friction_power(zone_begin + zone_length * nodes, share_of_way)
            total_work += float(weights @ (np.abs(zone_length) * power) @ weights)
        return total_work

    def locked(self, u: Array) -> Array:
        """Change of the tangential displacement U and of the shear's moment m_q = int x q dx since
        the stroke began, (2, n), at shares u of the stroke.

        By normal approach and moment of the pressure: those of the whole contact minus twice those
        of the contact that the stick zone would be, times f and the direction of slip.

        # notation: m, c centre and half-length of a contact
        """

        def carried(load: Array, tilt: Array) -> Array:
            m, c = self.interval(load, tilt)
            approach = self.shape.approach(m, c, tilt) + self.compliance * load / math.pi * np.log(
                2 / c
            )
            return np.stack([approach, self.shape.moment(m, c, tilt) / self.compliance])

        values_at_begin = carried(*self.pressed(np.zeros(1)))
        change_since_begin = (
            carried(*self.pressed(u)) - 2 * carried(*self.stuck(u)) + values_at_begin
        )
        return self.direction * self.friction * change_since_begin

    def density(self, x: Array, count: int = WAY_NODES) -> Array:
        """Friction work per area of this stroke at points x (k,): the integral of f p |ds| over its
        share u from 0 to 1 [energy per area].

        The stroke leads from one end of the cycle to the other. It is cut where an edge of the slip
        zone passes the point; each part takes `count` nodes.
        """

        def depth_in_slip_zone(x: Array, share_of_way: Array) -> Array:
            """Distance to the nearer end of the slip zone, positive within it."""
            stick_middle, stick_half_width = self.stick(share_of_way)
            contact_middle, half_width = self.contact(share_of_way)
            return np.minimum(
                np.abs(x - stick_middle) - stick_half_width, half_width - np.abs(x - contact_middle)
            )

        is_inside = depth_in_slip_zone(x, _SHARES[:, None]) > 0
        # Instants u at which an edge of the slip zone passes a point, by halving.
        interval_of_passing, passed_points = np.nonzero(is_inside[1:] != is_inside[:-1])
        least_share = _SHARES[interval_of_passing]
        largest_share = _SHARES[interval_of_passing + 1]
        for _ in range(_HALVINGS):
            middle_share = (least_share + largest_share) / 2
            has_passed = (depth_in_slip_zone(x[passed_points], middle_share) > 0) != is_inside[
                interval_of_passing, passed_points
            ]
            least_share = np.where(has_passed, least_share, middle_share)
            largest_share = np.where(has_passed, middle_share, largest_share)
        # Parts of the way that begin and end at its ends or where an edge passes, point by point.
        all_points = np.arange(len(x))
        points_of_parts = np.concatenate([all_points, passed_points, all_points])
        begin_shares = np.concatenate([0 * x, least_share, 0 * x + 1])
        order_by_point = np.lexsort((begin_shares, points_of_parts))
        points_of_parts = points_of_parts[order_by_point]
        begin_shares = begin_shares[order_by_point]
        part_numbers = np.flatnonzero(points_of_parts[1:] == points_of_parts[:-1])
        is_in_slip = (
            depth_in_slip_zone(
                x[points_of_parts[part_numbers]],
                (begin_shares[part_numbers] + begin_shares[part_numbers + 1]) / 2,
            )
            > 0
        )
        part_numbers = part_numbers[is_in_slip]
        nodes, weights = _angles(count)
        part_lengths = (begin_shares[part_numbers + 1] - begin_shares[part_numbers])[:, None]
        power = self.friction_power(
            x[points_of_parts[part_numbers], None],
            begin_shares[part_numbers, None] + part_lengths * nodes,
        )
        works_at_points = np.bincount(
            points_of_parts[part_numbers], (part_lengths * power) @ weights, len(x)
        )
        return np.asarray(works_at_points, dtype=float)


def ways_in_phase(scene: Scene) -> tuple[Way, Way] | None:
    """The forward and the reverse stroke of a cycle in which P, Q, bulk strain and tilt are in
    phase and both ends of the stick zone slip in one sense; None for any other cycle.

    In phase means that all loads lie on one line between two turning points, gone through once each
    way.
    """
    friction = scene.friction.coefficient
    if not scene.load.path().cycle or friction <= 0:
        return None
    profile = convex_profile(scene.profile)
    compliance = 2 / composite_modulus(scene.material)
    samples = cycle_samples(scene)
    load, force = samples[:2]
    loads_at_begin = samples[:, np.argmin(force)]
    loads_at_end = samples[:, np.argmax(force)]
    change_of_loads = loads_at_end - loads_at_begin
    rounding = LoadSizes.of(samples, profile, compliance, friction).rounding
    if change_of_loads[1] <= rounding[1] or not np.min(load) > 0:
        return None
    share_of_force = (force - loads_at_begin[1]) / change_of_loads[1]
    deviations = np.abs(
        samples - loads_at_begin[:, None] - np.outer(change_of_loads, share_of_force)
    )
    distances = np.max(deviations, axis=1)
    share_steps = np.diff(share_of_force, append=share_of_force[0])
    signs_of_steps = np.sign(share_steps[np.abs(share_steps) > _ROUNDING])
    if np.any(distances > rounding):
        return None
    if np.count_nonzero(signs_of_steps != np.roll(signs_of_steps, 1)) != 2:
        return None
    strokes = (
        Way(profile, compliance, friction, loads_at_begin, change_of_loads, 1),
        Way(profile, compliance, friction, loads_at_end, -change_of_loads, -1),
    )
    return strokes if all(stroke.recedes() for stroke in strokes) else None


def loop_of(ways: tuple[Way, Way]) -> float:
    """Closed integral of Q dU - m_q d eps, by parts: a second route to W, without slip."""
    node, weights = _angles(WAY_NODES)
    u = np.append(node, 1.0)
    change_at_begin = np.zeros((2, 1))
    loop_work = 0.0
    for way in ways:
        displacement, moment = change_at_begin + way.locked(u)
        loop_work -= weights @ (way.change[1] * displacement[:-1] + way.change[2] * moment[:-1])
        change_at_begin = np.array([displacement[-1:], moment[-1:]])
    return float(loop_work)
