"""Ciavarella-Jaeger superposition: shear traction q, slip s and relative tangential displacement U
from memory curves.

# notation: M'(eta) slope of the memory curve, A = 2/E*, P_x load at which a = |x|

q(x) = int M' dp(x, eta),  s(x) = (A/pi) int M' arccosh(|x|/a) d eta,  U = (A/pi) int M' ln(2 L/a) d
eta: one sum over the pieces of the curve with three kernels, for many instants and points at once.
What instants have in common, the pieces under the uppermost, is summed once.

Arcs: what a curved piece of the memory, travelled in full stick, leaves in q, s and U.

# notation: P_x load at which a = |x|; K kernel, of P alone or of P and x; P_t load at the turning
#           point of P next to an end of the arc; z^2 = |P - P_t|, e^2 = +-(P_x - P_t), negative
#           where P_x is beyond the turning point

    int Q'(t) K(x, P(t)) dt from the begin of the arc to each of many instants, P growing all along

    shear   K = 1/(pi sqrt(a^2 - x^2))  while |x| is inside
    slip    K = arccosh(|x|/a)          while |x| is outside
    shift   K = ln(2 L/a)

The arc is cut into panels, at the corners of the profile too. On a panel that is far from P_x (in
loads, measured by its own range) the integrand is smooth: one Chebyshev series in time serves all
instants, and its last coefficients are its error. Near P_x, whose inverse root (shear) or root
(slip) meets a mirror image at the turning point of P, the variable ln(z + sqrt(z^2 - e^2)) makes it
smooth, for e^2 < 0 too, and arcsin(z/e) where it is sqrt(e^2 - z^2): there Gauss' rule goes from
instant to instant. So an edge of contact anywhere, and an arc that begins next to the least load or
ends next to the largest, cost no digits. Where P is close to 0, for the length of a step, and
beside corners, behind which a(P) goes as d^(3/2), the rule for singular ends takes its place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise, takewhile
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from scenes import NORMAL_LOAD, TANGENTIAL_LOAD, LoadSegment
from scenes.array_types import Array
from scenes.chebyshev import DEGREE, NODES, series, tail
from semi_analytic.memory import CurvePart, Piece, Snapshot, front_time, pieces
from semi_analytic.profiles import Contact
from semi_analytic.punch_superposition import PunchSuperposition
from semi_analytic.quadrature import gauss, graded

Indices = NDArray[np.intp]
Kernel = Literal["shear", "slip", "shift"]

# Panels at first, halvings of one at most, and the share of the largest integral at which a series
# is resolved.
_PANELS = 12
_HALVINGS = 9
_RESOLVED = 1e-14
# Lengths of a range that the logarithm of no load must be away from it.
_AWAY = 4.0
# Ranges of a panel's load that P_x must be away from it: there the series leaves 5^-25 at most.
_FAR = 2.0
# Longest range of the variable, and how many of Gauss' nodes it takes. Against twice as many nodes
# tractions keep 2e-14 of the largest, slips and shifts 7e-14 (2e-13 for |x|^20).
_SPANS = ((0.12, 6), (0.4, 10), (1.2, 16), (2.5, 24), (6.0, 40), (math.inf, 80))
# Nodes that are held at a time.
_NODES = 2_000_000
# From coefficients of a series on [-1, 1] to those of its primitive from -1 on, over a panel of
# length 1.
_PRIMITIVE = chebyshev.chebint(np.eye(DEGREE + 1), lbnd=-1, axis=1) / 2
# Steps of which the error is looked at, and how many times what halves of them change it is: of a
# step that ends next to P_x, on a table, halves lose half as much themselves.
_SAMPLE = 40
_OF_HALVES = 2.5


class TurningPoint(NamedTuple):
    """A turning point of P at an end of the arc or beyond it: its time and load; `sign` +1 for a
    least P, -1 for a largest.

    `farthest` is the other end of the arc.
    """

    time: float
    load: float
    sign: float
    farthest: float


class _FarSeries(NamedTuple):
    """Series of the integrand on panels that are far from P_x, (n, nodes) of (panel, point); which
    panels are near it, (panels, k).
    """

    panel: Indices
    point: Indices
    coefficients: Array
    near: NDArray[np.bool_]


class _Panels(NamedTuple):
    """Panels of an arc that are resolved: ends (n,), whether they are near P_x (n, k), series
    (n, k, nodes) and what these leave out (n, k).
    """

    low: Array
    high: Array
    near: NDArray[np.bool_]
    series: Array
    error: Array

    def take(self, numbers: Indices | NDArray[np.bool_]) -> _Panels:
        """The chosen ones."""
        return _Panels._make(column[numbers] for column in self)


class Arc:
    """The integrals of one kernel over the arc of a piece, at |x| = `x` (k,), up to any instant of
    it.

    Pieces that are cut from one arc share it. Of a shift `x` plays no part: one column stands for
    all.

    Attributes
    ----------
    error
        largest error of the integrals so far, estimated: what series left out, and what steps
        differ from their halves by
    """

    error: float
    _error_of_panels: float

    def __init__(self, contact: Contact, kernel: Kernel, piece: Piece, x: Array) -> None:
        """Integrals of one kernel times dQ at |x| = `x` (k,) along an arc, a curved piece of memory
        curve that was loaded in full stick. The memory curve M(eta) is the tangential force of the
        flat punches up to the load eta.

        The kernels give shear, slip or displacement ("shift") of a flat punch of unit load. The arc
        is cut into panels of time, at corners of the profile too. On each the integral is a series
        in time, or is taken in steps where the load P_x at which the edge of contact is at x is
        near.
        """
        assert piece.arc is not None  # for the type checker: only called for arcs
        self._contact = contact
        self._kernel = kernel
        self._leg = piece.anchor.leg
        self._x = np.zeros(1) if kernel == "shift" else x
        # A shift has all loads behind it, also where x = 0 is never in contact.
        self._edge = np.zeros(1) if kernel == "shift" else contact.load(x)
        self._factor = 1 / math.pi if kernel == "shear" else 1.0
        first_time = piece.arc[0]
        last_time = piece.anchor.time
        corner_loads = contact.break_loads
        corner_loads = corner_loads[
            (corner_loads > piece.bottom) & (corner_loads < piece.anchor.normal)
        ]
        corner_times = front_time(piece, corner_loads) if len(corner_loads) else corner_loads
        self._turn_at_begin = _turn(self._leg, first_time, last_time)
        self._turn_at_end = _turn(self._leg, last_time, first_time)
        # Even between the corners: a panel that began just behind one would not be smooth.
        ends_of_smooth_parts = np.unique(
            np.clip([first_time, *corner_times, last_time], first_time, last_time)
        )
        panels_of_parts = np.maximum(
            np.ceil(np.diff(ends_of_smooth_parts) / (last_time - first_time) * _PANELS), 1
        ).astype(int)
        begins_of_panels = [
            np.linspace(a, b, n, endpoint=False)
            for a, b, n in zip(
                ends_of_smooth_parts[:-1], ends_of_smooth_parts[1:], panels_of_parts, strict=True
            )
        ]
        # a panel of a digit or two has no inner ends
        panel_ends = np.unique([*np.concatenate(begins_of_panels), last_time])
        time_of_middle_load = float(front_time(piece, (piece.bottom + piece.anchor.normal) / 2))
        self._middle = float(panel_ends[np.argmin(np.abs(panel_ends - time_of_middle_load))])
        self._follow(panel_ends)

    def up_to(self, time: Array) -> Array:
        """Integrals of the kernel times dQ from the begin of the arc to each time (n,), at the
        points of the arc (k,): shape (n, k).

        An arc is a curved piece of the memory curve M(eta), the tangential force of the flat
        punches up to the load eta. Its kernel is the shear, slip or displacement by a unit of load
        on a flat punch.

        >>> from scenes import ellipse_segment
        >>> from semi_analytic.hertz import HertzContact
        >>> from semi_analytic.memory import load_in_stick, instant
        >>> leg = ellipse_segment(
        ...     -math.pi, 0.0, (3.0, 1.0), (1.0, 0.25), 0.0
        ... )  # P from 2 to 4, dQ = dP/4
        >>> below = Piece(None, 2.0, instant(leg, -math.pi), 0.0)
        >>> contact = HertzContact(
        ...     modulus=math.pi, radius=1.0, datum_length=1.0
        ... )  # p(0, P) = sqrt(P)
        >>> arc = Arc(
        ...     contact,
        ...     "shear",
        ...     load_in_stick(below, leg, -math.pi, instant(leg, 0.0)),
        ...     np.zeros(1),
        ... )
        >>> arc.up_to(np.zeros(1)).round(12).tolist()  # (sqrt 4 - sqrt 2)/4
        [[0.146446609407]]
        """
        panel_ends = self._marks
        time = np.clip(time, panel_ends[0], panel_ends[-1])
        different_times, number_in_times = np.unique(time, return_inverse=True)
        panel = np.clip(
            np.searchsorted(panel_ends, different_times, side="right") - 1, 0, len(panel_ends) - 2
        )
        integrals = self._before[panel]
        share_of_panel = np.clip(
            (different_times - panel_ends[panel]) / (panel_ends[panel + 1] - panel_ends[panel]),
            0.0,
            1.0,
        )
        polynomials = chebyshev.chebvander(2 * share_of_panel - 1, DEGREE + 1)
        first_of_panel = np.flatnonzero(np.diff(panel, prepend=-1))
        for number_at_begin, number_beyond in pairwise(
            [*first_of_panel.tolist(), len(different_times)]
        ):
            in_panel = slice(number_at_begin, number_beyond)
            integrals[in_panel] += polynomials[in_panel] @ self._primitive[panel[number_at_begin]].T
        # Near P_x (the edge of contact passes the point) in steps from one time to the next, in
        # each panel from its begin.
        step_begins = np.append(panel_ends[0], different_times[:-1])
        step_begins[first_of_panel] = panel_ends[panel[first_of_panel]]
        step_number, point = np.nonzero(
            self._near[panel] & (different_times > step_begins)[:, None]
        )
        step_integrals = np.zeros(integrals.shape)
        step_integrals[step_number, point], error_of_steps = self._steps_and_error(
            step_begins[step_number], different_times[step_number], point
        )
        # Steps that end within a panel are other ones than those over all of it.
        self.error = max(self.error, self._error_of_panels + self._factor * error_of_steps)
        step_sums = np.cumsum(step_integrals, axis=0)
        sums_before = (step_sums - step_integrals)[first_of_panel]
        integrals += step_sums - np.repeat(
            sums_before, np.diff(np.append(first_of_panel, len(different_times))), axis=0
        )
        return self._factor * integrals[number_in_times.ravel()]

    def _follow(self, panel_ends: Array) -> None:
        """Integrate the kernel over the arc, panel of time by panel, and store the integrals up to
        the begin of each panel and their error.

        Far from P_x, the load at which the edge of contact is at the point, the integrand is a
        Chebyshev series on each panel; panels between `panel_ends` are halved until it is resolved.
        On a panel near P_x the integral is taken in one step, by a rule for singular ends.
        """
        panels = self._resolved(panel_ends[:-1], panel_ends[1:])
        self._near = panels.near
        self._marks = np.append(panels.low, panels.high[-1])
        self._primitive = panels.series @ _PRIMITIVE
        panel, point = np.nonzero(panels.near)
        integrals_of_steps, error_of_steps = self._steps_and_error(
            panels.low[panel], panels.high[panel], point
        )
        panel_integrals = np.sum(self._primitive, axis=2)
        panel_integrals[panel, point] += integrals_of_steps
        self._before = np.cumsum(panel_integrals, axis=0) - panel_integrals
        error_of_series = float(np.max(np.sum(panels.error, axis=0), initial=0.0))
        self._error_of_panels = self._factor * (error_of_steps + error_of_series)
        self.error = self._error_of_panels

    def _steps_and_error(self, begins: Array, ends: Array, point: Indices) -> tuple[Array, float]:
        """Integrals from begins[k] to ends[k] in time at x[point[k]], (m,), near the load at which
        the edge of contact is there, and the error of the sum of them at one point.

        The error comes from a sample of steps, which are taken in halves too: a multiple of the
        largest change, times the root of the number of steps at a point.
        """
        sampled_steps = np.empty(0, dtype=int)
        if len(point):
            sampled_steps = np.unique(np.linspace(0, len(point) - 1, _SAMPLE).astype(int))
        middles = (begins[sampled_steps] + ends[sampled_steps]) / 2
        # In one call: whole steps, then lower and upper halves of the sample.
        integrals = self._steps(
            np.concatenate([begins, begins[sampled_steps], middles]),
            np.concatenate([ends, middles, ends[sampled_steps]]),
            np.concatenate([point, point[sampled_steps], point[sampled_steps]]),
        )
        integrals_of_steps, lower_halves, upper_halves = np.split(
            integrals, [len(point), len(point) + len(sampled_steps)]
        )
        changes = integrals_of_steps[sampled_steps] - lower_halves - upper_halves
        largest_error = _OF_HALVES * float(np.max(np.abs(changes), initial=0.0))
        most_steps_of_point = np.max(np.bincount(point), initial=0)
        return integrals_of_steps, largest_error * math.sqrt(most_steps_of_point)

    def _resolved(self, begins: Array, ends: Array) -> _Panels:
        """Panels of time along the arc, (n,) ascending, each with a Chebyshev series of the
        integrand at those points that the edge of contact does not pass nearby.

        Panels between `begins` and `ends` are halved until the last coefficients of the series no
        longer count, or no number lies between their ends.
        """
        resolved_panels: list[_Panels] = []
        largest_integral = 0.0
        n_points = len(self._x)
        for halvings in range(_HALVINGS + 1):
            far_series = self._series(begins, ends)
            largest_coefficient = float(np.max(np.abs(far_series.coefficients[:, 0]), initial=0.0))
            largest_integral = max(largest_integral, largest_coefficient * math.sqrt(len(begins)))
            error = np.zeros((len(begins), n_points))
            error[far_series.panel, far_series.point] = tail(far_series.coefficients)
            coefficient_table = np.zeros((len(begins), n_points, DEGREE + 1))
            coefficient_table[far_series.panel, far_series.point] = far_series.coefficients
            middles = (begins + ends) / 2
            is_resolved = np.max(error, axis=1, initial=0.0) <= _RESOLVED * largest_integral
            is_resolved |= halvings == _HALVINGS
            is_resolved |= (middles == begins) | (middles == ends)  # no number lies between
            resolved_panels.append(
                _Panels(begins, ends, far_series.near, coefficient_table, error).take(is_resolved)
            )
            if np.all(is_resolved):
                break
            middles = middles[~is_resolved]
            begins = np.concatenate([begins[~is_resolved], middles])
            ends = np.concatenate([middles, ends[~is_resolved]])
        panels = _Panels._make(
            np.concatenate(column) for column in zip(*resolved_panels, strict=True)
        )
        return panels.take(np.argsort(panels.low))

    def _steps(self, begins: Array, ends: Array, point: Indices) -> Array:
        """Integrals of the kernel times dQ from begins[k] to ends[k] in time, at x[point[k]], (m,),
        where the edge of contact passes the point in that time or nearly.

        The variable of integration depends on the nearest turning point of P, before or behind the
        arc; no step crosses the middle of the arc.
        """
        integrals = np.empty(len(begins))
        is_upper = begins >= self._middle
        for turning_point, in_half in (
            (self._turn_at_begin, ~is_upper),
            (self._turn_at_end, is_upper),
        ):
            near_integral = _NearIntegral(self._contact, self._kernel, self._leg, turning_point)
            x_of_steps = self._x[point[in_half]]
            edge_loads = self._edge[point[in_half]]
            integrals[in_half] = near_integral.over(
                begins[in_half], ends[in_half], x_of_steps, edge_loads
            )
        return integrals

    def _series(self, begins: Array, ends: Array) -> _FarSeries:
        """Chebyshev series of the integrand, in time, on panels (n,), for those points that the
        edge of contact does not pass nearby; and which points it does.

        P_x is the load at which the edge is at a point. It is far from a panel where it lies
        outside the panel's range of loads by a multiple of that range.
        """
        contact = self._contact
        x = self._x
        edge_loads = self._edge
        time = begins[:, None] + (ends - begins)[:, None] * (1 + NODES) / 2
        load = np.maximum(self._leg.loads(time)[0], 0.0)
        least_load = np.maximum(self._leg.loads(begins)[0], 0.0)[:, None]
        largest_load = np.maximum(self._leg.loads(ends)[0], 0.0)[:, None]
        margin = _FAR * (largest_load - least_load)
        if self._kernel == "slip":
            is_at_no_load = least_load < margin
            is_near = (edge_loads > least_load) & (
                (edge_loads < largest_load + margin) | is_at_no_load
            )
            is_far = (edge_loads >= largest_load + margin) & ~is_at_no_load
        else:
            is_far = edge_loads <= least_load - margin
            is_near = (edge_loads < largest_load) & (edge_loads > least_load - margin)
        panel, point = np.nonzero(is_far)
        force_rate = self._leg.rate_of(TANGENTIAL_LOAD, time) * (ends - begins)[:, None]
        advance = contact.advance(load)
        coefficients = np.empty((len(panel), DEGREE + 1))
        pairs_at_once = _NODES // (DEGREE + 1)
        for k in range(0, len(panel), pairs_at_once):
            chunk = slice(k, k + pairs_at_once)
            panel_chunk = panel[chunk]
            point_chunk = point[chunk]
            load_above = load[panel_chunk] - edge_loads[point_chunk, None]
            values = _kernel(
                contact,
                self._kernel,
                x[point_chunk, None],
                load_above,
                load[panel_chunk],
                advance[panel_chunk],
            )
            coefficients[chunk] = series(force_rate[panel_chunk] * values)
        return _FarSeries(panel, point, coefficients, is_near)


@lru_cache(maxsize=16)  # kernels and points of one solution share its arcs
def _turn(segment: LoadSegment, arc_end: float, other_end: float) -> TurningPoint:
    """The turning point of the load P(t) at one end of an arc of a load segment, or beyond that end
    by less than the arc's length; the end itself where there is none.

    An arc is a part of the segment between the times `arc_end` and `other_end`. Newton's method on
    dP/dt; the formulas of the segment hold beyond its ends too.
    """
    arc_length = other_end - arc_end
    time_step = 1e-3 * arc_length
    # P grows along the arc: it is least at the begin, largest at the end.
    sign_of_curvature = math.copysign(1.0, arc_length)
    turning_time = arc_end
    for _ in range(20):
        load_rate = float(segment.rate_of(NORMAL_LOAD, turning_time))
        rate_after = segment.rate_of(NORMAL_LOAD, turning_time + time_step)
        rate_before = segment.rate_of(NORMAL_LOAD, turning_time - time_step)
        load_curvature = float(rate_after - rate_before) / (2 * time_step)
        newton_step = (
            load_rate / load_curvature if load_curvature * sign_of_curvature > 0 else math.inf
        )
        if abs(newton_step) > abs(arc_length) or (
            arc_end - turning_time + newton_step
        ) * sign_of_curvature < -abs(time_step):
            return TurningPoint(
                arc_end, float(segment.loads(arc_end)[0]), sign_of_curvature, other_end
            )
        turning_time -= newton_step
        if abs(newton_step) <= 1e-15 * (abs(turning_time) + abs(arc_length)):
            break
    turning_time = min(turning_time, arc_end) if arc_length > 0 else max(turning_time, arc_end)
    return TurningPoint(
        turning_time, float(segment.loads(turning_time)[0]), sign_of_curvature, other_end
    )


def _force_over_root(leg: LoadSegment, turn: TurningPoint, z: Array) -> Array:
    """|dQ/dz| with the sign of dQ/dt at z = sqrt(|P - P_t|), P_t the load at the turning point,
    from dP = 2 z dz; shape of z.
    """
    time = leg.time_of(NORMAL_LOAD, turn.sign * z * z, turn.time, turn.farthest)
    slope = np.abs(leg.rate_of(NORMAL_LOAD, time))
    force_rate = leg.rate_of(TANGENTIAL_LOAD, time)
    return np.asarray(force_rate * 2 * z / np.where(slope > 0, slope, np.inf))


def _kernel(
    contact: Contact, kernel: Kernel, x: Array, load_above: Array, load: Array, advance: Array
) -> Array:
    """Shear, slip or displacement at points `x` that a unit of load on a flat punch makes, in full
    stick; arrays of one shape.

        shear   1/sqrt(a^2 - x^2), pi times dp/dP
        slip    arccosh(|x|/a)
        shift   ln(2 L/a)

    Parameters
    ----------
    load_above
        P - P_x, P_x the load at which the edge of contact is at x
    load, advance
        P and the advance a - a_0 of the edge
    """
    if kernel == "shear":
        return contact.inverse_root(x, load_above, advance)
    if kernel == "slip":
        return contact.arccosh_ratio(x, -load_above, advance)
    return contact.log_ratio(load)


@dataclass(frozen=True, eq=False)
class _NearIntegral:
    """Integrals of one kernel K over time where the load P_x at which the edge of contact is at the
    point is among the loads of the range or close to them, or where P is close to 0; `turn` is the
    turning point of P beside them.
    """

    contact: Contact
    kernel: Kernel
    leg: LoadSegment
    turn: TurningPoint

    @property
    def beyond(self) -> bool:
        """Whether the kernel is not 0 for z^2 > e^2; else for z^2 < e^2."""
        return (self.kernel != "slip") == (self.turn.sign > 0)

    def over(self, begin_time: Array, end_time: Array, x: Array, load_at_x: Array) -> Array:
        """Integrals of dQ/dt K(x, P(t)) over time, (m,), by Gauss' rule in a variable s in which
        the integrand is smooth, where the edge of contact passes the point or nearly.

        # notation: P_t load at the turning point of P, z^2 = |P - P_t|, P_x load at which the edge
        #           of contact is at x, e^2 = P_x - P_t beside a least P, P_t - P_x beside a largest

        Where the kernel K is not 0 for z^2 > e^2, s = ln(z + sqrt(z^2 - e^2)) but for a constant;
        where it is not for z^2 < e^2, s = arcsin(z/e).

        Parameters
        ----------
        begin_time, end_time
            (m,) limits of the integrals, P monotonic from the turning point to both
        x, load_at_x
            (m,) a point for each integral, and its P_x
        """
        if not len(begin_time):
            return np.zeros(0)
        turn = self.turn
        z_at_begin = self._root_of_rise(begin_time)
        z_at_end = self._root_of_rise(end_time)
        least_z = np.minimum(z_at_begin, z_at_end)
        largest_z = np.maximum(z_at_begin, z_at_end)
        squared_e = turn.sign * (load_at_x - turn.load)
        # An e of 0 would stretch the variable for ever.
        least_square = 1e-36 * largest_z**2
        squared_e = np.where(np.abs(squared_e) < least_square, least_square, squared_e)
        # The part on the side of P_x where the kernel is not 0: z^2 > e^2 or z^2 < e^2.
        limit_function = _limits_beyond if self.beyond else _limits_within
        begin_s, end_s = limit_function(least_z, largest_z, squared_e)
        return self._over_variable(begin_s, end_s, x, squared_e)

    def _over_variable(self, begin_s: Array, end_s: Array, x: Array, squared_e: Array) -> Array:
        """Integrals of the kernel times dQ over ranges of the smooth variable s, (m,), from
        `begin_s` to `end_s`, each at its own point `x` with its own e^2.

        Gauss' rule with as many nodes as the range is long; the rule for singular ends where the
        integrand is rough; 0 for a range without length. e^2 is the distance of the load P_x, at
        which the edge of contact is at x, from the turning point of P.
        """
        is_rough = self._is_rough(begin_s, end_s - begin_s, squared_e)
        nodes = _nodes_of_ranges(begin_s, end_s, is_rough)
        integrals = np.zeros(len(begin_s))
        for k in range(0, len(nodes.s), _NODES):
            chunk = slice(k, k + _NODES)
            numbers = nodes.number[chunk]
            values = self._integrand(nodes.s[chunk], x[numbers], squared_e[numbers])
            integrals += np.bincount(numbers, nodes.weight[chunk] * values, len(integrals))
        return integrals

    def _root_of_rise(self, time: Array) -> Array:
        """z = sqrt(|P - P_t|) at times (m,), P_t the load at the turning point of P."""
        rise = self.leg.change_of(NORMAL_LOAD, time, self.turn.time)
        return np.sqrt(np.maximum(self.turn.sign * rise, 0.0))

    def _is_rough(self, begin_s: Array, s_length: Array, squared_e: Array) -> NDArray[np.bool_]:
        """Whether a range of the integration variable s (m,), from `begin_s` and `s_length` long,
        needs the rule for singular ends.

        The slip kernel has a logarithm where P = 0, at s = +-i arsinh(sqrt(P_t)/e). Too close to it
        Gauss' rule fails: at four lengths 6 nodes leave 16^-12. P_t is the load at the turning
        point of P, `squared_e` = e^2 its distance from the load of the point, with its sign. A
        displacement ("shift") takes that rule always: it has one point, and is cheap.
        """
        if self.kernel == "shift":
            return np.ones(len(begin_s), dtype=bool)
        if self.kernel != "slip" or self.beyond:
            return np.zeros(len(begin_s), dtype=bool)
        load_at_turn = max(self.turn.load, 0.0)
        least_square = 1e-200 * load_at_turn + 1e-300
        distance_of_logarithm = np.arcsinh(
            np.sqrt(load_at_turn / np.maximum(squared_e, least_square))
        )
        return np.asarray(np.hypot(begin_s, distance_of_logarithm) < _AWAY * s_length)

    def _integrand(self, s: Array, x: Array, squared_e: Array) -> Array:
        """dQ/ds K(x, P) at nodes s (n,), with the point x and e^2, the distance of P_x from the
        turning point of P with its sign, of each, (n,).
        """
        z, root = _z_and_root(s, squared_e, self.beyond)
        load = np.maximum(self.turn.load + self.turn.sign * z * z, 0.0)
        advance = self.contact.advance(load)
        load_above_edge = root * root if self.kernel != "slip" else -root * root
        kernel = _kernel(self.contact, self.kernel, x, load_above_edge, load, advance)
        return np.asarray(root * _force_over_root(self.leg, self.turn, z) * kernel)


class _RangeNodes(NamedTuple):
    """Nodes s of many ranges of a variable in one row, their weights, and the number of the range
    that each is of, (n,) each.
    """

    number: Indices
    s: Array
    weight: Array


def _nodes_of_ranges(begin_s: Array, end_s: Array, is_rough: NDArray[np.bool_]) -> _RangeNodes:
    """Quadrature nodes and weights of integrals over many ranges of a variable s, from `begin_s` to
    `end_s`, (m,) each, all in one row.

    Gauss' rule with as many nodes as the length of the range takes; the rule for singular ends
    where `is_rough`, (m,), is set; none where a range has no length. One row for all, since a call
    for each rule would take longer than its arithmetic.
    """
    s_length = end_s - begin_s
    number_of_rule = np.searchsorted([longest for longest, _ in _SPANS], s_length)
    rough_ranges = np.flatnonzero((s_length > 0) & is_rough)
    ranges = [rough_ranges]
    rules = [graded(begin_s[rough_ranges], end_s[rough_ranges])]
    for rule, (_, n_nodes) in enumerate(_SPANS):
        ranges_of_rule = np.flatnonzero((s_length > 0) & ~is_rough & (number_of_rule == rule))
        nodes, weights = gauss(n_nodes)
        length = s_length[ranges_of_rule, None]
        ranges.append(ranges_of_rule)
        rules.append((begin_s[ranges_of_rule, None] + length * nodes, length * weights))
    numbers_of_rules = [
        np.repeat(numbers, s.shape[1]) for numbers, (s, _) in zip(ranges, rules, strict=True)
    ]
    return _RangeNodes(
        np.concatenate(numbers_of_rules),
        np.concatenate([s.ravel() for s, _ in rules]),
        np.concatenate([weights.ravel() for _, weights in rules]),
    )


def _limits_beyond(least_z: Array, largest_z: Array, squared_e: Array) -> tuple[Array, Array]:
    """The integration variable s at both ends of ranges from `least_z` to `largest_z`, (m,) each,
    for kernels that act where z^2 > e^2: arcosh(z/e), 0 up to z = e; arsinh(z/|e|) for e^2 < 0.

    z is the root of P's distance from its turning point, e that of the load at which the edge of
    contact is at the point.
    """
    e = np.sqrt(np.abs(squared_e))

    def variable_at(z_limit: Array) -> Array:
        z = np.where(squared_e > 0, np.maximum(z_limit, e), z_limit)
        # (z - e)(z + e), not z^2 - e^2: at z = e round-off would leave a root of 1e-8 in the
        # latter.
        root = np.sqrt(np.maximum((z - e) * (z + e), 0.0))
        return np.arcsinh(np.where(squared_e > 0, root, z) / np.maximum(e, 1e-300))

    begin = variable_at(least_z)
    return begin, np.maximum(begin, variable_at(largest_z))


def _limits_within(least_z: Array, largest_z: Array, squared_e: Array) -> tuple[Array, Array]:
    """The integration variable s = arcsin(z/e) at both ends of ranges from `least_z` to
    `largest_z`, (m,) each, for kernels that act where z^2 < e^2; equal where nothing of the range
    is within.

    z is the root of P's distance from its turning point, e that of the load at which the edge of
    contact is at the point.
    """
    e = np.sqrt(np.maximum(squared_e, 0.0))

    def variable_at(z_limit: Array) -> Array:
        z = np.minimum(z_limit, e)
        return np.arctan2(z, np.sqrt((e - z) * (e + z)))

    begin = variable_at(least_z)
    return begin, np.maximum(begin, variable_at(largest_z))


def _z_and_root(s: Array, squared_e: Array, beyond: bool) -> tuple[Array, Array]:
    """z and the root sqrt(|z^2 - e^2|) at s, (n,) each, with dz = root ds: z > e where
    `beyond`, else z < e.
    """
    e = np.sqrt(np.abs(squared_e))
    if not beyond:
        return e * np.sin(s), e * np.cos(s)
    by_cosh = e * np.cosh(s)
    by_sinh = e * np.sinh(s)
    return np.where(squared_e > 0, by_cosh, by_sinh), np.where(squared_e > 0, by_sinh, by_cosh)


# Share of a load up to which a line of the memory is short: differences of slips keep 1e-15 of the
# whole, over its power 3/2.
_SHORT = 0.01


@dataclass(frozen=True, eq=False)
class Integrals:
    """int M'(eta) K(x, eta) d eta over memory curves at |x| = `x` (k,), with what is shared
    remembered.

    Attributes
    ----------
    contact
        normal contact of the profile
    x
        (k,) distances from the centre >= 0
    kernel
        "shear" (K = dp/d eta), "slip" (K = arccosh(|x|/a) outside, 0 inside) or "shift" (K =
        ln(2 L/a); x plays no part)
    """

    contact: Contact
    x: Array
    kernel: Kernel
    _known: dict[int, tuple[CurvePart, Array]] = field(default_factory=dict)
    _arcs: dict[tuple[int, float, float], tuple[Piece, Arc]] = field(default_factory=dict)

    def over(self, snapshot: Snapshot) -> Array:
        """Shear, slip or displacement of a contact at each instant of a snapshot of the friction
        memory, at each point, (n, k): the integral of M'(eta) K(x, eta) over the memory curve.

        M(eta) is the tangential force carried up to the load eta, K the kernel of a flat punch. At
        constant P the shear is that of Cattaneo and Mindlin, q = f [p(x, P) - p(x, P - Q/f)].

        >>> from scenes.segments import straight_segments
        >>> from semi_analytic.hertz import HertzContact
        >>> from semi_analytic.history import march, snapshot_of
        >>> contact = HertzContact(modulus=np.pi, radius=1.0, datum_length=1.0)  # p(0, P) = sqrt(P)
        >>> loading, slip = march(
        ...     None,
        ...     straight_segments([(0.0, 0.0, 0.0), (1.0, 4.0, 0.0), (2.0, 4.0, 1.5)]),
        ...     0.5,
        ...     0.0,
        ... )[0]
        >>> at_end = snapshot_of([(slip, np.array([2.0]))])  # M' = 0.5 from eta = 1 to P = 4
        >>> shear = Integrals(contact, np.zeros(1), "shear").over(at_end)
        >>> shear.round(12).tolist()  # 0.5 (sqrt 4 - sqrt 1)
        [[0.5]]
        >>> shift = Integrals(contact, np.zeros(1), "shift").over(at_end)
        >>> shift.round(12).tolist()  # U pi/A = 0.5 [4 ln(pi/2) + 2 - ln(pi) - 1/2], L = 1
        [[1.080800...]]
        """
        edge_load = snapshot.load - snapshot.slipped
        slopes = np.zeros(len(snapshot.load))
        bottoms = np.zeros(len(snapshot.load))
        for piece, instants in snapshot.groups:
            slopes[instants] = piece.straight_slope
            bottoms[instants] = piece.bottom
        slope_of_slip = np.asarray(snapshot.direction * snapshot.friction, dtype=float)
        # Line of slip above the stick edge, straight part of the piece below it; in one call, since
        # both need the kernel's integral up to the stick edge.
        integrals_of_lines = self._line(
            np.concatenate([slope_of_slip, slopes]),
            np.concatenate([edge_load, bottoms]),
            np.concatenate([snapshot.load, edge_load]),
        )
        integral_of_slip_line, integral_of_straight_part = np.split(integrals_of_lines, 2)
        integrals = integral_of_slip_line + integral_of_straight_part
        self._remember([piece.below for piece, _ in snapshot.groups])
        integrals_of_arcs = self._curved(
            [(piece, edge_load[instants]) for piece, instants in snapshot.groups]
        )
        for (piece, instants), integral_of_arc in zip(
            snapshot.groups, integrals_of_arcs, strict=True
        ):
            integrals[instants] += self._up_to_top(piece.below) + integral_of_arc
        return integrals

    def _up_to_top(self, curve: CurvePart | None) -> Array | float:
        """The integral over a curve that is known, (k,)."""
        return self._known[id(curve)][1] if curve is not None else 0.0

    def _remember(self, curves: Sequence[CurvePart | None]) -> None:
        """Integrate the kernel over those memory curves that are not stored yet, and store the
        integral up to the top of each of their pieces.

        A memory curve M(eta) is the tangential force of the flat punches up to the load eta. Curves
        share their lower pieces: each begins at the first stored piece. All straight parts are
        integrated in one call.
        """
        new_pieces: dict[int, CurvePart] = {}

        def is_unknown(piece: CurvePart) -> bool:
            return id(piece) not in self._known and id(piece) not in new_pieces

        for curve in curves:
            unknown_pieces = list(takewhile(is_unknown, pieces(curve)))
            new_pieces.update({id(piece): piece for piece in reversed(unknown_pieces)})
        if not new_pieces:
            return
        slopes = np.array([piece.straight_slope for piece in new_pieces.values()])
        bottoms = np.array([piece.bottom for piece in new_pieces.values()])
        tops = np.array([piece.top for piece in new_pieces.values()])
        integrals_of_lines = self._line(slopes, bottoms, tops)
        integrals_of_arcs = self._curved(
            [(piece, np.array([piece.top])) for piece in new_pieces.values()]
        )
        for piece, integral_of_line, integral_of_arc in zip(
            new_pieces.values(), integrals_of_lines, integrals_of_arcs, strict=True
        ):
            self._known[id(piece)] = (
                piece,
                self._up_to_top(piece.below) + integral_of_line + np.ravel(integral_of_arc),
            )

    def _line(self, slope: Array, bottom: Array, top: Array) -> Array:
        """Slope times int K d eta along straight parts of memory curves, from the loads `bottom` to
        `top` (n,), at each point: (n, k); 0 for parts without slope or length.

        A memory curve M(eta) is the tangential force of the flat punches up to the load eta. A
        short part is integrated by itself: the difference of two long integrals would leave little
        more than round-off.
        """
        line_integrals = np.zeros((len(top), len(self.x)))
        line_numbers = np.flatnonzero((slope != 0) & (top != bottom))
        is_short = np.zeros(len(line_numbers), dtype=bool)
        if self.kernel == "slip" and isinstance(self.contact, PunchSuperposition):
            length = top[line_numbers] - bottom[line_numbers]
            # Not across a corner of the profile, or close behind one: there a(P) is not smooth.
            corners = self.contact.break_loads
            corners_below = np.searchsorted(corners, bottom[line_numbers] - length)
            corners_above = np.searchsorted(corners, top[line_numbers])
            is_short = (length < _SHORT * top[line_numbers]) & (corners_below == corners_above)
        long_lines = line_numbers[~is_short]
        short_lines = line_numbers[is_short]
        if len(long_lines):
            integrals = self._difference(bottom[long_lines], top[long_lines])
            line_integrals[long_lines] = slope[long_lines, None] * integrals
        if len(short_lines):
            integrals = self._by_itself(bottom[short_lines], top[short_lines])
            line_integrals[short_lines] = slope[short_lines, None] * integrals
        return line_integrals

    def _difference(self, bottom: Array, top: Array) -> Array:
        different_loads, number_in_loads = np.unique(
            np.concatenate([bottom, top]), return_inverse=True
        )
        moments = self.moment(0, different_loads)
        return np.asarray(
            moments[number_in_loads[len(bottom) :]] - moments[number_in_loads[: len(bottom)]]
        )

    def _by_itself(self, bottom: Array, top: Array) -> Array:
        """The slip kernel's integral, of arccosh(|x|/a(eta)) from the loads `bottom` to `top` (n,),
        at each point: (n, k), as one integral of positive terms.

        It ends at P_x, the load at which the edge of contact is at x. With eta = end - v^2, v = e
        sinh(s), e^2 = P_x - end >= 0 the root of P_x - eta becomes smooth.
        """
        contact = self.contact
        edge_loads = contact.load(self.x)
        end_load = np.minimum(top[:, None], edge_loads)
        v_at_bottom = np.sqrt(np.maximum(end_load - bottom[:, None], 0.0))
        integrals = np.zeros(end_load.shape)
        root_beyond = np.sqrt(np.maximum(edge_loads - end_load, 0.0))
        is_near = root_beyond < 0.5 * v_at_bottom
        for is_of_rule, n_nodes in ((~is_near, 12), (is_near, 32)):
            line_number, point = np.nonzero((v_at_bottom > 0) & is_of_rule)
            e = np.maximum(root_beyond[line_number, point], 1e-4 * v_at_bottom[line_number, point])
            nodes, weights = gauss(n_nodes)
            s_length = np.arcsinh(v_at_bottom[line_number, point] / e)[:, None]
            v = e[:, None] * np.sinh(s_length * nodes)
            v_rate = e[:, None] * np.cosh(s_length * nodes)
            load_below_edge = np.square(v) + np.square(root_beyond[line_number, point])[:, None]
            advance = contact.advance(end_load[line_number, point, None] - np.square(v))
            arccosh_ratio = contact.arccosh_ratio(self.x[point, None], load_below_edge, advance)
            integrals[line_number, point] = np.sum(
                weights * s_length * 2 * v * v_rate * arccosh_ratio, axis=1
            )
        return integrals

    def _curved(
        self, pieces_and_edge_loads: Sequence[tuple[CurvePart, Array]]
    ) -> list[Array | float]:
        """What curved pieces of memory curves add to the integral of M' K, beyond their straight
        parts: (n, k), or 0, for each pair of a piece and loads (n,).

        A memory curve M(eta) is the tangential force of the flat punches up to the load eta. The
        integral goes from the lower end of the piece to the load at the stick edge. Pieces that are
        cut from one arc are integrated together.

        Parameters
        ----------
        pieces_and_edge_loads
            pairs of a piece and the loads (n,) at the stick edge, up to which it counts
        """
        integrals: list[Array | float] = [0.0] * len(pieces_and_edge_loads)
        pieces_of_arc: dict[tuple[int, float, float], list[tuple[int, Piece]]] = {}
        for pair_number, (piece, edge_load) in enumerate(pieces_and_edge_loads):
            if isinstance(piece, Piece) and piece.arc is not None:
                key = (id(piece.anchor.leg), piece.arc[0], piece.anchor.time)
                pieces_of_arc.setdefault(key, []).append((pair_number, piece))
            elif piece.bend:
                moments = self.moment(1, edge_load) - self.moment(1, np.array([piece.bottom]))
                integrals[pair_number] = 2 * piece.bend * moments
        for key, numbered_pieces in pieces_of_arc.items():
            _, piece = numbered_pieces[0]
            if key not in self._arcs:
                self._arcs[key] = piece, Arc(self.contact, self.kernel, piece, self.x)
            edge_loads_of_pieces = [
                pieces_and_edge_loads[pair_number][1] for pair_number, _ in numbered_pieces
            ]
            times = front_time(piece, np.concatenate(edge_loads_of_pieces))
            bounds = np.cumsum(
                [len(edge_loads_of_piece) for edge_loads_of_piece in edge_loads_of_pieces]
            )[:-1]
            integrals_of_pieces = np.split(self._arcs[key][1].up_to(times), bounds)
            for (pair_number, _), integral in zip(
                numbered_pieces, integrals_of_pieces, strict=True
            ):
                integrals[pair_number] = integral
        return integrals

    @property
    def arc_error(self) -> float:
        """Largest estimated error of the arcs that were integrated."""
        return max((arc.error for _, arc in self._arcs.values()), default=0.0)

    def moment(self, order: int, load: Array) -> Array:
        """int_0^load eta^order K d eta: shape (n, k) from (n,)."""
        contact = self.contact
        column = load[:, None]
        if self.kernel == "shift":
            function = (contact.log_distance, contact.log_moment)[order]
            return np.broadcast_to(function(column), (len(load), len(self.x)))
        if self.kernel == "shear":
            # All moments are taken as differences between two loads.
            return (contact.pressure_rise, contact.pressure_moment)[order](self.x, column)
        return (contact.slip_integral, contact.slip_integral_moment)[order](self.x, column)
