"""Large bulk stress at constant normal load: the two ends of a Hertzian contact slip opposite ways
(Nowell and Hills 1987).

# notation: A = 2/E*, k = E*/(2 R), p = k sqrt(a^2 - x^2), eps = kappa Q bulk strain in proportion
#           to Q; b1, b2 ends of stick, w = sqrt((b1 - xi)(b2 - xi)), m = (b1 + b2)/2, c = (b2 -
#           b1)/2; e = eps/(A f k a)

Above |eps| = (A/(pi a)) |Q| the stick zone leaves both edges, and shear has two signs on its two
sides. With eps < 0, right end forward and left end reverse,

    eps/(A f k) = m - (2/pi) int_{-a}^{b1} sqrt(a^2 - xi^2)/w d xi
    Q = f P + (pi eps/A) m - f k pi (m^2 + c^2/2) + 2 f k int_{-a}^{b1} xi sqrt(a^2 - xi^2)/w d xi

and for eps > 0 the same with -Q and -eps. While Q and eps grow in proportion the stick zones I are
nested, and q is a sum of the increments [1/pi - (kappa/A) t]/sqrt(c^2 - t^2) dQ on them. So the
memory curve of constant P holds with I(eta), eta = P - |Q|/f, in place of contact intervals of load
eta (Masing rule), and so do the formulas of s, U, m_q and W in `tilted_profile`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from scenes.array_types import Array
from scenes.chebyshev import PiecewiseSeries, piecewise_series_by_halving
from semi_analytic.quadrature import crowded_nodes, gauss_rule, graded_nodes
from semi_analytic.tilted_profile import TiltedProfile

KernelName = Literal["inverse_root", "arccosh_ratio"]
"""Kernel at x of a unit of load on a stick zone: of the traction, or of the slip."""
Rule = Callable[[Array, Array], tuple[Array, Array]]
"""Quadrature rule: nodes and weights on ranges from begin to end, along a new last axis."""

# Steps of the continuation in which the loads grow from nothing, and steps of Newton's method in
# each at most.
_LOAD_STEP_COUNT = 12
_MOST_NEWTON_STEPS = 30
# Step of difference quotients over the slip depth: Newton's method needs few digits of them.
_DIFFERENCE_SHARE_OF_DEPTH = 1e-6
# Integrals evaluated together, a bound on memory.
_MOST_INTEGRALS_AT_ONCE = 10_000


def loads_of_slip_depths(left_depth: Array, right_depth: Array) -> tuple[Array, Array]:
    """Dimensionless bulk strain e < 0 and tangential load Q/(f P) under which the two ends of a
    Hertzian contact slip in opposite directions up to given depths (n,): (n,) each.

    The contact is -1 < x < 1, in units of its half-width a, and sticks in -1 + d1 < x < 1 - d2.
    d1 = `left_depth`, d2 = `right_depth`. e = eps/(A f k a), with the bulk strain eps, A = 2/E*,
    k = E*/(2 R), R the radius of the parabola. Source: Nowell and Hills (1987), at constant P.

    >>> e, q = loads_of_slip_depths(
    ...     np.array([0.5]), np.array([0.5])
    ... )  # Q = 0: -e = (2/pi) [K(m) - E(m)] by elliptic integrals, m = 1 - c^2, c stick half-width
    >>> round(float(e[0]), 10), round(abs(float(q[0])), 12)
    (-0.601898288, 0.0)
    """
    stick_centre = (left_depth - right_depth) / 2
    stick_half_width = 1 - (left_depth + right_depth) / 2
    # xi = b1 - d1 v^2: places in the left slip zone; b1, b2 left and right stick edge, v the nodes
    nodes, weights = graded_nodes(np.zeros(left_depth.shape), np.ones(left_depth.shape))
    depth_at_nodes = left_depth[..., None] * (1 - nodes * nodes)
    xi = depth_at_nodes - 1
    root_ratio = np.sqrt(
        (1 - nodes)
        * (1 + nodes)
        * (2 - depth_at_nodes)
        / (2 - depth_at_nodes - right_depth[..., None])
    )
    # sqrt(1 - xi^2)/w d xi, w = sqrt((b1 - xi)(b2 - xi))
    integrand_weights = weights * 2 * left_depth[..., None] * root_ratio
    e = stick_centre - 2 / np.pi * np.sum(integrand_weights, axis=-1)
    moment_term = 4 / np.pi * np.sum(xi * integrand_weights, axis=-1)
    force_over_limit = (
        1
        + 2 * e * stick_centre
        - 2 * stick_centre * stick_centre
        - stick_half_width * stick_half_width
        + moment_term
    )
    return e, force_over_limit


def slip_depths_of_loads(e: Array, force: Array) -> tuple[Array, Array]:
    """Depths d1 and d2 of the slip zones of a Hertzian contact -1 < x < 1 whose left and right end
    slip in opposite directions, (n,) each, from the loads.

    `e` < 0 is the dimensionless bulk strain eps/(A f k a), `force` is Q/(f P), (n,) each. A = 2/E*,
    k = E*/(2 R), R the radius of the parabola, a the half-width of contact. `loads_of_slip_depths`
    gives both from the depths. They grow in proportion from nothing at constant P.

    Raises
    ------
    ArithmeticError
        Where no depths are found: one slip zone closes again, or the stick zone shrinks to nothing.
    """
    loads = np.stack([e, force])
    with np.errstate(invalid="ignore", divide="ignore"):
        # by Newton's method; NaN or no solution where it fails
        slip_depths = _depths_by_newton(loads)
        residual_of_loads = np.abs(np.stack(loads_of_slip_depths(*slip_depths)) - loads)
    if not np.all(residual_of_loads <= 1e-11 * np.abs(loads).max(axis=0)):
        raise ArithmeticError("no stick zone with slip of opposite sense at both ends")
    left_depth, right_depth = slip_depths
    return left_depth, right_depth


def _depths_by_newton(loads: Array) -> Array:
    """Depths of the slip zones at the left and the right end of a Hertzian contact, (2, n), under
    given bulk strain and tangential load, by Newton's method.

    The contact is -1 < x < 1 in units of its half-width; `loads` (2, n) are the dimensionless bulk
    strain e < 0 and Q/(f P). The loads grow in steps, each starting from the solution of the step
    before. Where the method fails the result is NaN or no solution. `loads_of_slip_depths` gives
    the loads under which slip has given depths.
    """
    e, force_over_limit = loads
    # first guess, for a twelfth of the loads
    slip_depths = (
        np.stack([-e - force_over_limit / 2, -e + force_over_limit / 2]) / _LOAD_STEP_COUNT
    )
    # _LOAD_STEP_COUNT: 12; _MOST_NEWTON_STEPS: 30
    for load_step in range(1, _LOAD_STEP_COUNT + 1):
        load_fraction = load_step / _LOAD_STEP_COUNT
        for _ in range(_MOST_NEWTON_STEPS):
            residual_of_loads = np.stack(loads_of_slip_depths(*slip_depths)) - load_fraction * loads
            newton_step = _newton_step(slip_depths, residual_of_loads)
            # Never more than half the way to an end of contact, or to where both slip zones meet.
            longest_newton_step = np.minimum(
                slip_depths / 2, np.maximum(2 - slip_depths.sum(axis=0), 0.0) / 4
            )
            slip_depths = slip_depths - np.clip(
                newton_step, -longest_newton_step, longest_newton_step
            )
            is_converged = np.all(np.abs(newton_step) <= 1e-14 * slip_depths)
            if is_converged or not np.all(np.isfinite(slip_depths)):
                break

        # first guess of the next load step, unless the slip zones would meet
        if load_step < _LOAD_STEP_COUNT:
            extrapolated_depths = slip_depths * (load_step + 1) / load_step
            slip_depths = np.where(
                extrapolated_depths.sum(axis=0) < 2, extrapolated_depths, slip_depths
            )
    return slip_depths


def _newton_step(slip_depths: Array, residual_of_loads: Array) -> Array:
    """Newton's step of the slip depths (2, n) at both ends of the contact, to be subtracted;
    `residual_of_loads` (2, n): dimensionless bulk strain e and Q/(f P) of these `slip_depths`,
    minus those that are wanted.

    Derivatives are central differences of 1e-6 of the depths; the two equations are solved by
    Cramer's rule. `loads_of_slip_depths` gives both loads from the depths.
    """
    load_derivatives = []
    for end_number in (0, 1):
        depth_difference = (
            _DIFFERENCE_SHARE_OF_DEPTH * slip_depths * (np.arange(2) == end_number)[:, None]
        )
        loads_after_difference = np.stack(loads_of_slip_depths(*(slip_depths + depth_difference)))
        loads_before_difference = np.stack(loads_of_slip_depths(*(slip_depths - depth_difference)))
        load_derivatives.append(
            (loads_after_difference - loads_before_difference) / (2 * depth_difference[end_number])
        )
    (e_by_left_depth, force_by_left_depth), (e_by_right_depth, force_by_right_depth) = (
        load_derivatives
    )
    residual_of_e, residual_of_force = residual_of_loads
    determinant = e_by_left_depth * force_by_right_depth - e_by_right_depth * force_by_left_depth
    left_numerator = force_by_right_depth * residual_of_e - e_by_right_depth * residual_of_force
    right_numerator = e_by_left_depth * residual_of_force - force_by_left_depth * residual_of_e
    return np.stack([left_numerator, right_numerator]) / determinant


def _gauss_nodes(begin: Array, end: Array) -> tuple[Array, Array]:
    """Eight nodes and weights of Gauss' rule on [begin, end], a new last axis."""
    unit_nodes, unit_weights = gauss_rule(8)
    range_length = (end - begin)[..., None]
    return begin[..., None] + range_length * unit_nodes, range_length * unit_weights


@lru_cache(maxsize=8)  # the same zones under other values of `kernel_quantity`
def _stick_edge_series(
    strain_per_unloading: float, force_per_unloading: float, largest_unloading: float
) -> tuple[PiecewiseSeries, PiecewiseSeries]:
    """Left and right stick edges b1/a and b2/a of a Hertzian contact |x| < a, as functions of the
    unloading P - eta = |Q|/f, from 0 to `largest_unloading`: piecewise Chebyshev series.

    The dimensionless bulk strain e and Q/(f P) grow with the unloading: -e is
    `strain_per_unloading` times it, Q/(f P) `force_per_unloading` times it. `slip_depths_of_loads`
    gives the depths of both slip zones over a.
    """

    def stick_edges(unloading: Array) -> tuple[Array, Array]:
        """b1/a and b2/a at values of P - eta, arrays of one shape."""
        left_depth, right_depth = slip_depths_of_loads(
            -strain_per_unloading * unloading.ravel(), force_per_unloading * unloading.ravel()
        )
        left_edge = (left_depth - 1).reshape(unloading.shape)
        right_edge = (1 - right_depth).reshape(unloading.shape)
        return left_edge, right_edge

    # Chebyshev series over this range, to round-off of 1, the size of the edges over a
    unloading_range = np.array([0.0, largest_unloading])
    return (
        piecewise_series_by_halving(
            lambda unloading: stick_edges(unloading)[0], unloading_range, 1.0
        ),
        piecewise_series_by_halving(
            lambda unloading: stick_edges(unloading)[1], unloading_range, 1.0
        ),
    )


@dataclass(frozen=True, eq=False)
class OppositeSlip(TiltedProfile):
    """A parabola at constant P under a large bulk strain eps = kappa Q, so that the two ends of
    contact slip in opposite directions.

    In place of contact intervals under loads eta, I(eta) are the stick zones after |Q| = f (P -
    eta); `P - eta` is called the unloading.

    Attributes
    ----------
    friction, largest_tangential_load
        f, and the largest |Q| of the path [force per thickness]; P is the largest load of
        `intervals`
    tangential_fraction
        1; 0 where Q = 0 and bulk strain alone changes: then a fictitious load T stands in the place
        of Q, eps = kappa T
    """

    friction: float = 1.0
    largest_tangential_load: float = 1.0
    tangential_fraction: float = 1.0  # type: ignore[misc]

    @property
    def has_closed_form(self) -> bool:
        return True

    @cached_property
    def _contact(self) -> tuple[float, float, float]:
        """P [force per thickness], and centre and half-width of the contact [length]."""
        m, c = self.intervals.exact_centre_and_half_width(self.intervals.largest_load)
        return self.intervals.largest_load, float(m), float(c)

    @property
    def _largest_unloading(self) -> float:
        """P - eta = |Q|/f at the largest |Q| [force per thickness]."""
        return self.largest_tangential_load / self.friction

    @cached_property
    def _stick_edges(self) -> tuple[PiecewiseSeries, PiecewiseSeries]:
        """Left and right stick edges as functions of the unloading P - eta [force per thickness]:
        their distances b1/a and b2/a from the centre of contact, b1 < b2.

        I(eta) is the stick zone after |Q| = f (P - eta), and P - eta the unloading. The series need
        -e and Q/(f P) per unloading. With A P = pi a^2/(2 R), e = eps pi a/(2 A f P), the
        dimensionless bulk strain; A = 2/E*, R is the radius of the parabola, a the contact
        half-width. `pressure_skewness` is pi kappa/A, eps = kappa Q; `_contact` holds P, centre and
        half-width of the contact.
        """
        largest_load, _, half_width = self._contact
        # `tangential_fraction`: 1, or 0 where Q = 0 and bulk strain alone changes
        force_per_unloading = (
            -self.tangential_fraction * float(np.sign(self.pressure_skewness)) / largest_load
        )
        strain_per_unloading = abs(self.pressure_skewness) * half_width / (2 * largest_load)
        return _stick_edge_series(
            strain_per_unloading, force_per_unloading, self._largest_unloading * (1 + 1e-9)
        )

    @cached_property
    def _conjugate_contact(self) -> OppositeSlip:
        """This contact with kernels of U + kappa m_q, which is conjugate to Q in the friction work.

        U is the tangential displacement, m_q the moment of the shear, kappa the bulk strain over Q.
        """
        return replace(self, kernel_quantity="conjugate_displacement")

    def centre_and_half_width(self, load: ArrayLike) -> tuple[Array, Array]:
        """Centre and half-width of the stick zone I(eta) at loads eta, any shape [length].

        I(eta) is the stick zone after |Q| = f (P - eta); P - eta is the unloading. Beyond the
        largest unloading the values are those at the largest. At eta = P they are those of the
        contact. `_contact` holds P, centre and half-width of the contact.
        """
        largest_load, contact_centre, contact_half_width = self._contact
        unloading = np.clip(
            largest_load - np.asarray(load, dtype=float), 0.0, self._largest_unloading
        )
        # functions of the unloading, edges over the contact half-width
        left_edge_at, right_edge_at = self._stick_edges
        left_edge = left_edge_at(unloading)
        right_edge = right_edge_at(unloading)
        stick_centre = contact_centre + contact_half_width * (left_edge + right_edge) / 2
        return stick_centre, contact_half_width * (right_edge - left_edge) / 2

    def is_nested(self, load: float) -> bool:
        """Whether the stick zones recede at both ends while |Q| grows to its largest; `load` is the
        constant P.
        """
        stick_edges = self.interval(load - self._largest_unloading * np.linspace(0, 1, 200))
        length_slack = 1e-12 * self._contact[2]
        return bool(
            np.all(np.diff(stick_edges[:, 0]) >= -length_slack)
            and np.all(np.diff(stick_edges[:, 1]) <= length_slack)
        )

    def load(self, half_width: ArrayLike) -> Array:
        """Load P_x = P - |Q|/f at which a stick edge passes the place x, any shape [force per
        thickness].

        P is constant. While |Q| grows, eta = P - |Q|/f falls and the stick zone I(eta) recedes; P_x
        is the eta at which its edge is at x, found by bisection. It is 0 where the point sticks up
        to the largest |Q|, and above P beyond the contact, in proportion to the distance from its
        edge. Here x is the argument `half_width`, with its sign.
        """
        # the constant load P, then centre and half-width of the contact
        largest_load, contact_centre, contact_half_width = self._contact
        relative_x = (np.asarray(half_width, dtype=float) - contact_centre) / contact_half_width
        # of the unloading at which the stick edge passes x
        lower_bound = np.zeros(relative_x.shape)
        upper_bound = np.full(relative_x.shape, self._largest_unloading)
        # functions of the unloading, edges over the contact half-width
        left_edge_at, right_edge_at = self._stick_edges
        for _ in range(60):
            unloading = (lower_bound + upper_bound) / 2
            is_outside_stick_zone = np.where(
                relative_x < 0,
                relative_x < left_edge_at(unloading),
                relative_x > right_edge_at(unloading),
            )
            lower_bound = np.where(is_outside_stick_zone, lower_bound, unloading)
            upper_bound = np.where(is_outside_stick_zone, unloading, upper_bound)
        largest_unloading = np.array(self._largest_unloading)
        always_sticks = (relative_x >= left_edge_at(largest_unloading)) & (
            relative_x <= right_edge_at(largest_unloading)
        )
        load_at_x = np.where(always_sticks, 0.0, largest_load - (lower_bound + upper_bound) / 2)
        distance_beyond_contact = np.abs(relative_x) - 1
        return np.where(
            distance_beyond_contact > 0, largest_load * (1 + distance_beyond_contact), load_at_x
        )

    def slip_direction_at(self, x: ArrayLike) -> Array:
        """+1 where x slips forward while Q grows, -1 where it slips in reverse."""
        _, contact_centre, _ = self._contact
        sign_of_side = np.where(np.asarray(x, dtype=float) > contact_centre, -1.0, 1.0)
        return sign_of_side * np.sign(self.pressure_skewness)

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Pressure p(x) at the constant load P, times the direction of slip at x while Q grows, +1
        or -1: so q/f where x slips [stress].
        """
        _, contact_centre, contact_half_width = self._contact
        unsigned_pressure = self.profile.pressure(
            np.asarray(x, dtype=float), np.array(contact_centre), np.array(contact_half_width)
        ) / (np.pi * self.intervals.compliance)
        return np.asarray(
            self.slip_direction_at(x) * unsigned_pressure + 0 * np.asarray(load, dtype=float)
        )

    def _integral_up_to_largest_load(
        self, x: ArrayLike, load: ArrayLike, kernel: KernelName
    ) -> Array:
        """Shear q/f or slip at places x, but for a factor, after |Q| has grown at constant P: the
        integral of a kernel K(x, eta) over eta from `load` to P. Arrays broadcast.

        I(eta) is the stick zone after |Q| = f (P - eta). K is the effect at x of a unit of load on
        I(eta): pi times the traction ("inverse_root"), or pi/A times the slip ("arccosh_ratio"), A
        = 2/E*. The ranges between neighbouring loads are integrated one by one, and summed from P
        down. `_largest_unloading` is P - eta at the largest |Q|.
        """
        # `intervals`: the contact under each load; its largest load is P
        largest_load = self.intervals.largest_load
        least_load = largest_load - self._largest_unloading
        places, loads = np.broadcast_arrays(
            np.asarray(x, dtype=float), np.clip(load, least_load, largest_load)
        )
        different_places, column_of_place = np.unique(places, return_inverse=True)
        different_loads, row_of_load = np.unique(loads, return_inverse=True)
        # integrals over the ranges between neighbouring loads, (ranges, places)
        range_integrals = self._integrals_between_loads(
            different_places, np.append(different_loads, largest_load), kernel
        )
        # summed from the largest load down
        integrals = np.cumsum(range_integrals[::-1], axis=0)[::-1]
        return np.asarray(
            integrals[row_of_load.ravel(), column_of_place.ravel()].reshape(places.shape)
        )

    def _integrals_between_loads(self, x: Array, load: Array, kernel: KernelName) -> Array:
        """Integrals over eta of a kernel K(x, eta), the effect at x of a unit of load on the stick
        zone I(eta): row i from `load[i]` to `load[i + 1]`, at places x (k,), (n, k).

        I(eta) is the stick zone after |Q| = f (P - eta); `load` (n + 1,) ascends to the constant P.
        P_x is the eta at which a stick edge is at x. The traction, "inverse_root", is integrated
        where x is inside I(eta), eta > P_x; the slip, "arccosh_ratio", where it is outside. Both
        are singular at P_x: ranges closer to it than three times their length take a rule for
        singular ends, `graded_nodes`, the others Gauss' rule.
        """
        largest_load = load[-1]  # P
        lower_load = load[:-1, None]
        upper_load = load[1:, None]
        # P_x; adding 0 times it gives ends of ranges for each x, (n, k)
        load_with_edge_at_x = self.load(x)
        integration_begin = lower_load + 0 * load_with_edge_at_x
        if kernel == "inverse_root":
            least_load = largest_load - self._largest_unloading
            integration_end = upper_load + 0 * load_with_edge_at_x
            distance_to_singularity = lower_load - np.maximum(load_with_edge_at_x, least_load)
            is_integrated = (lower_load >= load_with_edge_at_x) & (upper_load > lower_load)
        else:
            integration_end = np.minimum(upper_load, load_with_edge_at_x)
            distance_to_singularity = (
                np.minimum(load_with_edge_at_x, largest_load) - integration_end
            )
            is_integrated = integration_end > integration_begin

        range_integrals = np.zeros(is_integrated.shape)
        is_near_singularity = distance_to_singularity < 3 * (upper_load - lower_load)
        for takes_rule, rule in (
            (is_integrated & is_near_singularity, graded_nodes),
            (is_integrated & ~is_near_singularity, _gauss_nodes),
        ):
            range_integrals[takes_rule] = self._integrals_by_rule(
                np.broadcast_to(x, is_integrated.shape)[takes_rule],
                integration_begin[takes_rule],
                integration_end[takes_rule],
                kernel,
                rule,
            )
        return range_integrals

    def _integrals_by_rule(
        self, x: Array, begin_load: Array, end_load: Array, kernel: KernelName, rule: Rule
    ) -> Array:
        """Integrals over eta of a kernel K(x, eta) by one quadrature rule, (n,): each at its own
        place `x`, from `begin_load` to `end_load`, (n,) each.

        `rule` gives nodes and weights on such ranges, along a new last axis. At most 10,000
        integrals are evaluated together, a bound on memory.
        """
        integrals = np.zeros(len(x))
        for first_integral in range(0, len(x), _MOST_INTEGRALS_AT_ONCE):
            block = slice(first_integral, first_integral + _MOST_INTEGRALS_AT_ONCE)
            eta, weights = rule(begin_load[block], end_load[block])
            # the kernel method of that name
            kernel_at_nodes = getattr(self, kernel)(x[block, None], 0.0, eta)
            integrals[block] = np.sum(weights * kernel_at_nodes, axis=-1)
        return integrals

    def pressure_rise(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Integral of dp/d eta at x from P to `load`: -q(x)/f after |Q| = f (P - load) [stress].
        dp/d eta is the traction by a unit of load on the stick zone I(eta); outside of all zones
        q/f is the pressure with the sign of slip.
        """
        sticks = self.load(x) < np.minimum(load, self.intervals.largest_load)
        shear_in_stick_zone = self._integral_up_to_largest_load(x, load, "inverse_root") / np.pi
        return -np.where(sticks, shear_in_stick_zone, self.pressure(x, load))

    def slip_integral(self, x: ArrayLike, load: ArrayLike) -> Array:
        """Integral of the slip kernel `arccosh_ratio` at x over eta, from P to `load`."""
        return -self._integral_up_to_largest_load(x, load, "arccosh_ratio")

    def approach_integral(self, load: ArrayLike) -> Array:
        """Integral of `log_datum_ratio` over eta from P to `load`, so minus the integral from
        `load` to P; shape of `load`. The integrand is what a unit of load on the stick zone I(eta),
        that after |Q| = f (P - eta), adds to the tangential displacement or another quantity.
        """
        largest_load = self.intervals.largest_load
        least_load = np.clip(load, largest_load - self._largest_unloading, largest_load)
        eta, weights = graded_nodes(least_load, np.full(np.shape(least_load), largest_load))
        return np.asarray(-np.sum(weights * self.log_datum_ratio(eta), axis=-1))

    def dissipation_kernel(self, load: ArrayLike, slip_zone_load: ArrayLike) -> Array:
        """Kernel Lam of the friction work under the loads P and P_c [force per thickness], P_c the
        load at the stick edge.

        Lam is the integral of g(P_c) - g(eta) over eta from P_c = load - slip_zone_load to P. g is
        the rate of (U + kappa m_q) pi/A per load on I(eta), the stick zone after |Q| = f (P - eta).
        U is the tangential displacement, m_q the moment of the shear, kappa the bulk strain over Q,
        A = 2/E*.
        """
        load, slip_zone_load = np.broadcast_arrays(
            np.asarray(load, dtype=float), np.asarray(slip_zone_load, dtype=float)
        )
        # `log_datum_ratio` of the same contact for U + kappa m_q
        rate_per_load = self._conjugate_contact.log_datum_ratio
        stick_edge_load = load - slip_zone_load
        eta, weights = crowded_nodes(stick_edge_load, load)
        return np.asarray(
            np.sum(
                weights * (rate_per_load(stick_edge_load)[..., None] - rate_per_load(eta)), axis=-1
            )
        )
