"""Large bulk stress at constant normal load: the two ends of a Hertzian contact slip opposite ways
(Nowell and Hills 1987).

# notation: A = 2/E*, k = E*/(2 R), p = k sqrt(a^2 - x^2), eps = kappa Q bulk strain in proportion
#           to Q; b1, b2 ends of stick, w = sqrt((b1 - xi)(b2 - xi)), m = (b1 + b2)/2, c = (b2 -
#           b1)/2; e = eps/(A f k a)

Above |eps| = (A/(pi a)) |Q| the stick zone leaves both edges, and friction has two signs on its two
sides. With eps < 0, right end forward and left end reverse,

    eps/(A f k) = m - (2/pi) int_{-a}^{b1} sqrt(a^2 - xi^2)/w d xi
    Q = f P + (pi eps/A) m - f k pi (m^2 + c^2/2) + 2 f k int_{-a}^{b1} xi sqrt(a^2 - xi^2)/w d xi

and for eps > 0 the same with -Q and -eps. While Q and eps grow in proportion the stick zones I are
nested, and q is a sum of the increments [1/pi - (kappa/A) t]/sqrt(c^2 - t^2) dQ on them. So the
memory curve of constant P holds with I(eta), eta = P - |Q|/f, in place of contact intervals of load
eta (Masing rule), and so do the formulas of s, U, m_q and W in `tilted_profile`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from scenes.array_types import Array
from scenes.chebyshev import Pieces, halved
from semi_analytic.quadrature import crowded_nodes, gauss, graded
from semi_analytic.tilted_profile import TiltedProfile

# Parts in which loads grow from nothing to those asked for, and steps of Newton's method in each at
# most.
_PARTS = 12
_STEPS = 30
# Step by which derivatives are taken: they need few digits.
_WIDTH = 1e-6
# Integrals that are taken at a time.
_MEMBERS = 10_000


def loads_of(left: Array, right: Array) -> tuple[Array, Array]:
    """Bulk strain and tangential load under which a parabola's ends slip in opposite senses, up to
    given depths of slip; Nowell and Hills' problem at constant P, (n,) each.

    The contact is -1 < x < 1. It slips up to the depth d1 = `left` from its left end and d2 =
    `right` from its right end. Returned are the scaled bulk strain e < 0 and Q/(f P).

    >>> e, q = loads_of(
    ...     np.array([0.5]), np.array([0.5])
    ... )  # Q = 0: -e = (2/pi) [K(m) - E(m)], m = 1 - c^2
    >>> round(float(e[0]), 10), round(abs(float(q[0])), 12)
    (-0.601898288, 0.0)
    """
    stick_middle = (left - right) / 2
    stick_half_width = 1 - (left + right) / 2
    # notation: xi = b1 - d1 v^2 places in the left slip zone, b1 the left stick edge, v the nodes
    nodes, weights = graded(np.zeros(left.shape), np.ones(left.shape))
    depth = left[..., None] * (1 - nodes * nodes)
    xi = depth - 1
    root_ratio = np.sqrt((1 - nodes) * (1 + nodes) * (2 - depth) / (2 - depth - right[..., None]))
    terms = weights * 2 * left[..., None] * root_ratio
    e = stick_middle - 2 / np.pi * np.sum(terms, axis=-1)
    moment = 4 / np.pi * np.sum(xi * terms, axis=-1)
    return (
        e,
        1
        + 2 * e * stick_middle
        - 2 * stick_middle * stick_middle
        - stick_half_width * stick_half_width
        + moment,
    )


def slip_depths(e: Array, force: Array) -> tuple[Array, Array]:
    """Depths d1 and d2 of slip at the left and the right end of the contact -1 < x < 1 of a
    parabola at constant P, (n,) each.

    The scaled bulk strain `e` < 0 and Q/(f P) = `force`, (n,) each, grow in proportion from
    nothing; the ends slip in opposite senses.

    Raises
    ------
    ArithmeticError
        Where there are none: one slip zone closes again, or sticks next to nothing.
    """
    loads = np.stack([e, force])
    with np.errstate(invalid="ignore", divide="ignore"):
        depths = _depths(loads)
        residual = np.abs(np.stack(loads_of(*depths)) - loads)
    if not np.all(residual <= 1e-11 * np.abs(loads).max(axis=0)):
        raise ArithmeticError("no stick zone with slip of opposite sense at both ends")
    left, right = depths
    return left, right


def _depths(loads: Array) -> Array:
    """Depths of slip (2, n) at the left and the right end of the contact -1 < x < 1 under `loads`
    (2, n), scaled bulk strain e < 0 and Q/(f P), by Newton's method.

    The loads grow in parts, each from the solution of the part before. NaN, or no solution, where
    the method fails.
    """
    e, force = loads
    depth = np.stack([-e - force / 2, -e + force / 2]) / _PARTS
    for part in range(1, _PARTS + 1):
        load_share = part / _PARTS
        for _ in range(_STEPS):
            residual_of_loads = np.stack(loads_of(*depth)) - load_share * loads
            step = _newton_step(depth, residual_of_loads)
            # Never more than half the way to an end of contact, or to where both slip zones meet.
            longest_step = np.minimum(depth / 2, np.maximum(2 - depth.sum(axis=0), 0.0) / 4)
            depth = depth - np.clip(step, -longest_step, longest_step)
            if np.all(np.abs(step) <= 1e-14 * depth) or not np.all(np.isfinite(depth)):
                break
        if part < _PARTS:
            next_depth = depth * (part + 1) / part
            depth = np.where(next_depth.sum(axis=0) < 2, next_depth, depth)
    return depth


def _newton_step(depth: Array, residual: Array) -> Array:
    """Newton's change of the slip depths at both ends of the contact, (2, n), for residuals (2, n)
    of the two loads, bulk strain and Q/(f P), that the depths give.

    Derivatives are central differences; the system of two equations is solved in closed form.
    """
    rates = []
    for end_number in (0, 1):
        difference = _WIDTH * depth * (np.arange(2) == end_number)[:, None]
        loads_after = np.stack(loads_of(*(depth + difference)))
        loads_before = np.stack(loads_of(*(depth - difference)))
        rates.append((loads_after - loads_before) / (2 * difference[end_number]))
    (e_by_left, force_by_left), (e_by_right, force_by_right) = rates
    residual_of_e, residual_of_force = residual
    determinant = e_by_left * force_by_right - e_by_right * force_by_left
    step_of_left = force_by_right * residual_of_e - e_by_right * residual_of_force
    step_of_right = e_by_left * residual_of_force - force_by_left * residual_of_e
    return np.stack([step_of_left, step_of_right]) / determinant


def _by_gauss(begin: Array, end: Array) -> tuple[Array, Array]:
    """Nodes and weights of Gauss' rule on [begin, end], a new last axis."""
    node, weight = gauss(8)
    length = (end - begin)[..., None]
    return begin[..., None] + length * node, length * weight


@lru_cache(maxsize=8)  # the same zones under other values of `rigid`
def _stick_zones(eccentric: float, forced: float, largest_load: float) -> tuple[Pieces, Pieces]:
    """b1/a and b2/a over P - eta up to `largest_load`: -e = `eccentric` (P - eta) and Q/(f P) =
    `forced` (P - eta).
    """

    def ends(v: Array) -> tuple[Array, Array]:
        left, right = slip_depths(-eccentric * v.ravel(), forced * v.ravel())
        return (left - 1).reshape(v.shape), (1 - right).reshape(v.shape)

    marks = np.array([0.0, largest_load])
    return halved(lambda v: ends(v)[0], marks, 1.0), halved(lambda v: ends(v)[1], marks, 1.0)


@dataclass(frozen=True, eq=False)
class OppositeSlip(TiltedProfile):
    """The parabola at constant P under bulk strain kappa Q that is large; its I(eta), eta <= P, are
    stick zones.

    Attributes
    ----------
    friction, largest_tangential_load
        f, and the largest |Q| that is asked for; P is the largest load of `intervals`
    tangential_fraction
        1; 0 where Q = 0, and a load T that nobody applies stands in its place: eps = kappa T
    """

    friction: float = 1.0
    largest_tangential_load: float = 1.0
    tangential_fraction: float = 1.0  # type: ignore[misc]

    @property
    def closed_form(self) -> bool:
        return True

    @cached_property
    def _contact(self) -> tuple[float, float, float]:
        """P, and centre and half-length of contact."""
        m, c = self.intervals.exactly(self.intervals.largest_load)
        return self.intervals.largest_load, float(m), float(c)

    @property
    def _deepest(self) -> float:
        """P - eta of the largest Q."""
        return self.largest_tangential_load / self.friction

    @cached_property
    def _zones(self) -> tuple[Pieces, Pieces]:
        """b1 and b2 from the centre of contact, over a, as functions of P - eta: e = eps pi a/(2 A
        f P), for A P = pi a^2/(2 R).
        """
        largest_load, _, half_width = self._contact
        forced = -self.tangential_fraction * float(np.sign(self.lean)) / largest_load
        return _stick_zones(
            abs(self.lean) * half_width / (2 * largest_load), forced, self._deepest * (1 + 1e-9)
        )

    @cached_property
    def _as_loop(self) -> OppositeSlip:
        return replace(self, rigid="loop")

    def at(self, load: ArrayLike) -> tuple[Array, Array]:
        largest_load, middle, half_width = self._contact
        v = np.clip(largest_load - np.asarray(load, dtype=float), 0.0, self._deepest)
        left_of_v, right_of_v = self._zones
        left = left_of_v(v)
        right = right_of_v(v)
        return middle + half_width * (left + right) / 2, half_width * (right - left) / 2

    def is_nested(self, load: float) -> bool:
        """Whether stick zones recede at both ends, whatever the load is."""
        ends = self.interval(load - self._deepest * np.linspace(0, 1, 200))
        slack = 1e-12 * self._contact[2]
        return bool(np.all(np.diff(ends[:, 0]) >= -slack) and np.all(np.diff(ends[:, 1]) <= slack))

    def load(self, half_width: ArrayLike) -> Array:
        """The load P_x = P - |Q|/f of the force at which the stick edge passes each place x =
        `half_width`, by bisection [force per thickness].

        At constant P the stick zone under |Q| takes the place of the contact under the smaller load
        P - |Q|/f. Out of contact the value exceeds P, in proportion to the distance from the edge;
        it is 0 where nothing slips up to the largest Q.
        """
        largest_load, middle, contact_half_width = self._contact
        relative_place = (np.asarray(half_width, dtype=float) - middle) / contact_half_width
        least_unloading = np.zeros(relative_place.shape)
        largest_unloading = np.full(relative_place.shape, self._deepest)
        left_edge, right_edge = self._zones
        for _ in range(60):
            unloading = (least_unloading + largest_unloading) / 2
            is_outside = np.where(
                relative_place < 0,
                relative_place < left_edge(unloading),
                relative_place > right_edge(unloading),
            )
            least_unloading = np.where(is_outside, least_unloading, unloading)
            largest_unloading = np.where(is_outside, unloading, largest_unloading)
        deepest_unloading = np.array(self._deepest)
        never_slips = (relative_place >= left_edge(deepest_unloading)) & (
            relative_place <= right_edge(deepest_unloading)
        )
        loads = np.where(never_slips, 0.0, largest_load - (least_unloading + largest_unloading) / 2)
        distance_beyond = np.abs(relative_place) - 1
        return np.where(distance_beyond > 0, largest_load * (1 + distance_beyond), loads)

    def sense(self, x: ArrayLike) -> Array:
        """+1 where x slips forward while Q grows, -1 where it slips in reverse."""
        _, middle, _ = self._contact
        side = np.where(np.asarray(x, dtype=float) > middle, -1.0, 1.0)
        return side * np.sign(self.lean)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x) at the constant load, with the sign of `sense`: q/f where x slips [stress]."""
        _, middle, half_width = self._contact
        pressure = self.shape.pressure(
            np.asarray(x, dtype=float), np.array(middle), np.array(half_width)
        ) / (np.pi * self.intervals.compliance)
        return np.asarray(self.sense(x) * pressure + 0 * np.asarray(load, dtype=float))

    def _to_the_top(
        self, x: ArrayLike, load: ArrayLike, kernel: Literal["inverse_root", "arccosh_ratio"]
    ) -> Array:
        """Integral over loads eta from `load` to the largest load P of a kernel K(x, eta) at places
        x: shear or slip of a unit of load on each stick zone.

        "inverse_root" (shear) is integrated over the loads at which x is inside the zone, eta >
        P_x; "arccosh_ratio" (slip) over those at which it is outside, eta < P_x. P_x is the load at
        which the zone's edge is at x. The ranges between neighbouring loads are integrated one by
        one and summed from P down: those close to P_x by the rule for singular ends, the others by
        Gauss' rule.
        """
        largest_load = self.intervals.largest_load
        least_load = largest_load - self._deepest
        places, loads = np.broadcast_arrays(
            np.asarray(x, dtype=float), np.clip(load, least_load, largest_load)
        )
        different_places, column_of_place = np.unique(places, return_inverse=True)
        different_loads, row_of_load = np.unique(loads, return_inverse=True)
        load_below = different_loads[:, None]
        load_above = np.append(different_loads[1:], largest_load)[:, None]
        edge_load = self.load(different_places)
        begin_loads = load_below + 0 * edge_load
        if kernel == "inverse_root":
            end_loads = load_above + 0 * edge_load
            distance_to_edge_load = load_below - np.maximum(edge_load, least_load)
            is_integrated = (load_below >= edge_load) & (load_above > load_below)
        else:
            end_loads = np.minimum(load_above, edge_load)
            distance_to_edge_load = np.minimum(edge_load, largest_load) - end_loads
            is_integrated = end_loads > begin_loads
        range_integrals = np.zeros(is_integrated.shape)
        is_near = distance_to_edge_load < 3 * (load_above - load_below)
        for pairs_of_rule, rule in (
            (is_integrated & is_near, graded),
            (is_integrated & ~is_near, _by_gauss),
        ):
            range_number, point_number = np.nonzero(pairs_of_rule)
            for first_pair in range(0, len(range_number), _MEMBERS):
                pairs = (
                    range_number[first_pair : first_pair + _MEMBERS],
                    point_number[first_pair : first_pair + _MEMBERS],
                )
                eta, weight = rule(begin_loads[pairs], end_loads[pairs])
                kernel_at_nodes = getattr(self, kernel)(different_places[pairs[1], None], 0.0, eta)
                range_integrals[pairs] = np.sum(weight * kernel_at_nodes, axis=-1)
        integrals = np.cumsum(range_integrals[::-1], axis=0)[::-1]
        return np.asarray(
            integrals[row_of_load.ravel(), column_of_place.ravel()].reshape(places.shape)
        )

    def pressure_rise(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Integral of dp/d eta up to a load, less that up to P: -q/f after Q = f (P - eta)."""
        sticks = self.load(x) < np.minimum(load, self.intervals.largest_load)
        of_stick = self._to_the_top(x, load, "inverse_root") / np.pi
        return -np.where(sticks, of_stick, self.pressure(x, load))

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Integral of the kernel of slip up to a load, less that up to P."""
        return -self._to_the_top(x, load, "arccosh_ratio")

    def log_distance(self, load: ArrayLike) -> Array:
        """Integral of `log_ratio` up to a load, less that up to P."""
        largest_load = self.intervals.largest_load
        least_load = np.clip(load, largest_load - self._deepest, largest_load)
        eta, weight = graded(least_load, np.full(np.shape(least_load), largest_load))
        return np.asarray(-np.sum(weight * self.log_ratio(eta), axis=-1))

    def dissipation_kernel(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam = int_{P_c}^P of the loop's rate at P_c less that at eta [force per thickness]."""
        load, slipped = np.broadcast_arrays(
            np.asarray(load, dtype=float), np.asarray(slipped, dtype=float)
        )
        rate = self._as_loop.log_ratio
        front = load - slipped
        eta, weight = crowded_nodes(front, load)
        return np.asarray(np.sum(weight * (rate(front)[..., None] - rate(eta)), axis=-1))
