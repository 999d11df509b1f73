"""Ciavarella-Jaeger superposition: shear traction q, slip s and relative tangential displacement U
from memory curves.

# notation: M'(eta) slope of the memory curve, A = 2/E*, P_x load at which a = |x|

The memory curve M(eta) is the tangential force that the flat punches up to the load eta carry. It
consists of pieces: straight lines, parabolas and arcs, each of which a part of the load path left.

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
from scenes.chebyshev import (
    CHEBYSHEV_DEGREE,
    CHEBYSHEV_NODES,
    chebyshev_coefficients,
    truncation_error,
)
from semi_analytic.memory import CurvePart, Piece, Snapshot, pieces, time_of_load_on_arc
from semi_analytic.profiles import Contact
from semi_analytic.punch_superposition import PunchSuperposition
from semi_analytic.quadrature import gauss_rule, graded_nodes

Indices = NDArray[np.intp]
Kernel = Literal["shear", "slip", "shift"]

# Panels at first, halvings of one at most, and the share of the largest integral at which a series
# is resolved.
_FIRST_PANELS = 12
_HALVINGS = 9
_RESOLVED_SHARE = 1e-14
# Lengths of a range that the logarithm of no load must be away from it.
_LENGTHS_FROM_LOGARITHM = 4.0
# Ranges of a panel's load that P_x must be away from it: there the series leaves 5^-25 at most.
_RANGES_TO_FAR = 2.0
# Longest range of the variable, and how many of Gauss' nodes it takes. Against twice as many nodes
# tractions keep 2e-14 of the largest, slips and shifts 7e-14 (2e-13 for |x|^20).
_NODES_BY_LENGTH = ((0.12, 6), (0.4, 10), (1.2, 16), (2.5, 24), (6.0, 40), (math.inf, 80))
# Nodes that are held at a time.
_NODES_AT_ONCE = 2_000_000
# From coefficients of a series on [-1, 1] to those of its primitive from -1 on, over a panel of
# length 1.
_PRIMITIVE_OF_SERIES = chebyshev.chebint(np.eye(CHEBYSHEV_DEGREE + 1), lbnd=-1, axis=1) / 2
# Ranges of time near P_x whose error is looked at, and how many times the change by their halves
# it is: of a range that ends next to P_x, on a table, halves lose half as much themselves.
_SAMPLED_RANGES = 40
_ERROR_OVER_CHANGE = 2.5


class TurningPoint(NamedTuple):
    """A turning point of P at an end of the arc or beyond it: its time and load; `sign` +1 for a
    least P, -1 for a largest.

    `other_end_time` is the time of the other end of the arc.
    """

    time: float
    load: float
    sign: float
    other_end_time: float


class _FarSeries(NamedTuple):
    """Chebyshev series in time of the integrand on panels of time, at points far from the edge of
    contact then.

    Attributes
    ----------
    panel, point
        (n,) numbers of the panel and of the point of each pair that has a series
    coefficients
        (n, nodes) of the series
    is_near
        (panels, k) whether the edge of contact passes the point on the panel, or nearly
    """

    panel: Indices
    point: Indices
    coefficients: Array
    is_near: NDArray[np.bool_]


class _Panels(NamedTuple):
    """Panels of time along an arc.

    Attributes
    ----------
    begin, end
        (n,) times at their ends
    is_near
        (n, k) whether the edge of contact passes the point, or nearly
    series
        (n, k, nodes) coefficients of the Chebyshev series of the integrand; 0 where there is none
    error
        (n, k) truncation errors of these series
    """

    begin: Array
    end: Array
    is_near: NDArray[np.bool_]
    series: Array
    error: Array

    def take(self, numbers: Indices | NDArray[np.bool_]) -> _Panels:
        """The panels of these numbers, or of a mask."""
        return _Panels._make(column[numbers] for column in self)


class ArcIntegrals:
    """Integrals of one kernel times dQ along an arc, a curved piece of a memory curve, at |x| = `x`
    (k,), up to any instant of it.

    An arc is a curved segment of the load path that was travelled in full stick while P grew.
    Pieces that are cut from one arc share it. For the displacement ("shift") `x` plays no part: one
    column stands for all points.

    Attributes
    ----------
    error
        largest error of the integrals so far, estimated: what series leave out, and what
        integrals near the edge of contact change when their range is halved
    """

    error: float
    _error_of_panels: float

    def __init__(self, contact: Contact, kernel: Kernel, piece: Piece, x: Array) -> None:
        """Integrals of one kernel times dQ at |x| = `x` (k,) along an arc, panel of time by panel:
        what this arc of the memory curve adds to shear, slip or displacement.

        An arc is a curved piece of the memory curve: it comes from a curved segment of the load
        path that was travelled in full stick while P grew.
        The kernel is the shear, slip or displacement ("shift") that a unit tangential force on a
        flat punch makes. The arc is cut into panels, at the loads of the profile's corners too. P_x
        is the load at which the edge of contact is at the point. On a panel far from P_x the
        integral is a Chebyshev series in time; near P_x it is taken by Gauss' rule.

        Parameters
        ----------
        contact
            normal contact of the profile: P(a), loads of its corners, and the kernels
        kernel
            "shear", "slip" or "shift" (displacement)
        piece
            piece of the memory curve with the arc, from its `bottom_load` on. `arc_times` are times
            of its ends. `anchor` is the instant at the end of the arc, before any of it was cut
            off, with its load segment
        x
            (k,) distances from the middle; not used for the displacement
        """
        assert piece.arc_times is not None  # for the type checker: only called for arcs
        self._contact = contact
        self._kernel = kernel
        self._segment = piece.anchor.segment
        self._x = np.zeros(1) if kernel == "shift" else x

        # P_x of the points. The displacement takes all loads, whether x = 0 is in contact or not.
        self._edge_loads = np.zeros(1) if kernel == "shift" else contact.load(x)
        # dp/dP has the factor 1/pi before the inverse root.
        self._kernel_factor = 1 / math.pi if kernel == "shear" else 1.0

        # Turning point of P at, or just beyond, each end of the arc.
        first_time = piece.arc_times[0]
        last_time = piece.anchor.time
        self._turn_at_begin = _turning_point(self._segment, first_time, last_time)
        self._turn_at_end = _turning_point(self._segment, last_time, first_time)
        panel_ends = _first_panel_ends(piece, contact.corner_loads)
        # Integrals near P_x take the turning point of P on their side of this time, the panel end
        # that is nearest to the middle of the arc's loads.
        middle_load = (piece.bottom_load + piece.anchor.normal_load) / 2
        time_of_middle_load = float(time_of_load_on_arc(piece, middle_load))
        self._middle_time = float(panel_ends[np.argmin(np.abs(panel_ends - time_of_middle_load))])
        self._integrate_panels(panel_ends)

    def up_to(self, time: Array) -> Array:
        """Integrals of the kernel times dQ from the begin of the arc to each time (n,), at the
        points of the arc (k,): shape (n, k). Times beyond an end of the arc count as that end.

        An arc is a curved segment of the load path that was travelled in full stick while P grew.
        The kernel is the shear, slip or displacement that a unit tangential force on a flat punch
        makes.

        >>> from scenes import ellipse_segment
        >>> from semi_analytic.hertz import HertzContact
        >>> from semi_analytic.memory import load_in_stick, instant
        >>> segment = ellipse_segment(
        ...     -math.pi, 0.0, (3.0, 1.0), (1.0, 0.25), 0.0
        ... )  # P from 2 to 4, dQ = dP/4
        >>> below = Piece(None, 2.0, instant(segment, -math.pi), 0.0)
        >>> contact = HertzContact(
        ...     modulus=math.pi, radius=1.0, datum_length=1.0
        ... )  # p(0, P) = sqrt(P)
        >>> arc = ArcIntegrals(
        ...     contact,
        ...     "shear",
        ...     load_in_stick(below, segment, -math.pi, instant(segment, 0.0)),
        ...     np.zeros(1),
        ... )
        >>> arc.up_to(np.zeros(1)).round(12).tolist()  # (sqrt 4 - sqrt 2)/4
        [[0.146446609407]]
        """
        time = np.clip(time, self._panel_ends[0], self._panel_ends[-1])
        different_times, number_in_times = np.unique(time, return_inverse=True)
        panel_of_time = np.clip(
            np.searchsorted(self._panel_ends, different_times, side="right") - 1,
            0,
            len(self._panel_ends) - 2,
        )
        # up to the begin of the panel, then far from and near the edge of contact within it
        integrals = self._integrals_before_panel[panel_of_time]
        integrals += self._integrals_of_series(different_times, panel_of_time)
        integrals += self._near_integrals_in_panels(different_times, panel_of_time)
        # 1/pi for the shear, else 1
        return self._kernel_factor * integrals[number_in_times.ravel()]

    def _integrals_of_series(self, times: Array, panel_of_time: Indices) -> Array:
        """Integrals of the kernel times dQ from the begin of the panel to each time (n,), at points
        that the edge of contact does not pass nearby, (n, k); 0 at the others.

        They are primitives of the Chebyshev series on the panels. `times` ascend, `panel_of_time`
        (n,) is the number of the panel that each is in.
        """
        panel_begins = self._panel_ends[panel_of_time]
        panel_lengths = self._panel_ends[panel_of_time + 1] - panel_begins
        fraction_of_panel = np.clip((times - panel_begins) / panel_lengths, 0.0, 1.0)
        # CHEBYSHEV_DEGREE: that of the series; its primitive has one more.
        polynomials = chebyshev.chebvander(2 * fraction_of_panel - 1, CHEBYSHEV_DEGREE + 1)
        integrals = np.empty((len(times), len(self._x)))
        # numbers of the first time in each panel, and of the one after its last
        first_time_in_panel = np.flatnonzero(np.diff(panel_of_time, prepend=-1))
        for first_time_number, end_time_number in pairwise(
            [*first_time_in_panel.tolist(), len(times)]
        ):
            in_panel = slice(first_time_number, end_time_number)
            primitives_of_panel = self._primitives[panel_of_time[first_time_number]]
            integrals[in_panel] = polynomials[in_panel] @ primitives_of_panel.T
        return integrals

    def _near_integrals_in_panels(self, times: Array, panel_of_time: Indices) -> Array:
        """Integrals of the kernel times dQ from the begin of the panel to each time (n,), at points
        that the edge of contact passes nearby within the panel, (n, k); 0 at the others.

        They are sums over ranges from one time to the next, the first of a panel from its begin, by
        Gauss' rule. Their error raises `error`. `times` ascend, `panel_of_time` (n,) is the number
        of the panel that each is in.
        """
        panel_ends = self._panel_ends
        first_time_in_panel = np.flatnonzero(np.diff(panel_of_time, prepend=-1))
        range_begins = np.append(panel_ends[0], times[:-1])
        range_begins[first_time_in_panel] = panel_ends[panel_of_time[first_time_in_panel]]
        has_length = (times > range_begins)[:, None]
        range_number, point_number = np.nonzero(self._is_near[panel_of_time] & has_length)
        near_integrals = np.zeros((len(times), len(self._x)))
        near_integrals[range_number, point_number], error_of_near_integrals = (
            self._near_integrals_and_error(
                range_begins[range_number], times[range_number], point_number
            )
        )
        # These ranges have errors of their own: they are not the panels.
        self.error = max(
            self.error, self._error_of_panels + self._kernel_factor * error_of_near_integrals
        )
        # sums from the begin of each panel to each time
        sums_from_first_time = np.cumsum(near_integrals, axis=0)
        sums_before_panel = (sums_from_first_time - near_integrals)[first_time_in_panel]
        n_times_in_panel = np.diff(np.append(first_time_in_panel, len(times)))
        return np.asarray(
            sums_from_first_time - np.repeat(sums_before_panel, n_times_in_panel, axis=0)
        )

    def _integrate_panels(self, panel_ends: Array) -> None:
        """Integrate the kernel times dQ over the arc, panel of time by panel, and store the
        integrals up to the begin of each of n panels, at k points, (n, k), and their error.

        P_x is the load at which the edge of contact is at the point. Far from P_x the integrand is
        a Chebyshev series on each panel; panels between `panel_ends` are halved until it is
        resolved. On a panel near P_x the integral is taken by Gauss' rule in a variable that makes
        it smooth.

        The kernel is the shear, slip or displacement by a unit tangential force on a flat punch. An
        arc is a part of a curved load segment, travelled in full stick.
        """
        # Of each panel: begin, end, Chebyshev coefficients and error, and which points are near.
        panels = self._resolved_panels(panel_ends[:-1], panel_ends[1:])
        self._is_near = panels.is_near
        self._panel_ends = np.append(panels.begin, panels.end[-1])
        # Series of the integral from the begin of each panel on. Its value at the end of the panel
        # is the sum of its coefficients.
        self._primitives = panels.series @ _PRIMITIVE_OF_SERIES
        panel_integrals = np.sum(self._primitives, axis=2)
        near_panel, near_point = np.nonzero(panels.is_near)
        near_integrals, error_of_near_integrals = self._near_integrals_and_error(
            panels.begin[near_panel], panels.end[near_panel], near_point
        )
        panel_integrals[near_panel, near_point] += near_integrals
        self._integrals_before_panel = np.cumsum(panel_integrals, axis=0) - panel_integrals
        error_of_series = float(np.max(np.sum(panels.error, axis=0), initial=0.0))
        self._error_of_panels = self._kernel_factor * (error_of_near_integrals + error_of_series)
        self.error = self._error_of_panels

    def _near_integrals_and_error(
        self, begins: Array, ends: Array, point_number: Indices
    ) -> tuple[Array, float]:
        """Integrals of the kernel times dQ over ranges of time in which the edge of contact passes
        the point or nearly, (m,); and the estimated error of their sum at one point.

        The error comes from a sample of 40 ranges that are halved: 2.5 times the largest change,
        times the root of the largest number of ranges at one point. The kernel is the shear, slip
        or displacement by a unit tangential force on a flat punch.

        Parameters
        ----------
        begins, ends
            (m,) limits of each range of time
        point_number
            (m,) number of the point of each range, among those of the arc
        """
        sampled_ranges = np.empty(0, dtype=int)
        if len(point_number):
            sampled_ranges = np.unique(
                np.linspace(0, len(point_number) - 1, _SAMPLED_RANGES).astype(int)
            )
        middles = (begins[sampled_ranges] + ends[sampled_ranges]) / 2
        sampled_points = point_number[sampled_ranges]
        # In one call: all ranges, then lower and upper halves of the sample.
        integrals = self._near_integrals(
            np.concatenate([begins, begins[sampled_ranges], middles]),
            np.concatenate([ends, middles, ends[sampled_ranges]]),
            np.concatenate([point_number, sampled_points, sampled_points]),
        )
        integrals_of_ranges, lower_halves, upper_halves = np.split(
            integrals, [len(point_number), len(point_number) + len(sampled_ranges)]
        )
        changes = integrals_of_ranges[sampled_ranges] - lower_halves - upper_halves
        largest_error = _ERROR_OVER_CHANGE * float(np.max(np.abs(changes), initial=0.0))
        most_ranges_of_point = np.max(np.bincount(point_number), initial=0)
        return integrals_of_ranges, largest_error * math.sqrt(most_ranges_of_point)

    def _resolved_panels(self, begins: Array, ends: Array) -> _Panels:
        """Panels of time along the arc, (n,) ascending, on which a Chebyshev series resolves the
        integrand at all points that the edge of contact does not pass nearby, with these series.

        Panels between `begins` and `ends` (m,) are halved, nine times at most, until the last
        coefficients of the series no longer count, or no number lies between their ends.

        The integrand is the rate of Q times the kernel: the shear, slip or displacement at a point
        by a unit tangential force on a flat punch. An arc is a part of a curved load segment,
        travelled in full stick.
        """
        resolved_panels: list[_Panels] = []
        largest_integral = 0.0
        for n_halvings in range(_HALVINGS + 1):
            panels = self._panels_with_series(begins, ends)
            largest_coefficient = float(np.max(np.abs(panels.series[:, :, 0]), initial=0.0))
            largest_integral = max(largest_integral, largest_coefficient * math.sqrt(len(begins)))
            middles = (begins + ends) / 2
            # errors up to 1e-14 of the largest integral
            is_resolved = (
                np.max(panels.error, axis=1, initial=0.0) <= _RESOLVED_SHARE * largest_integral
            )
            is_resolved |= n_halvings == _HALVINGS
            is_resolved |= (middles == begins) | (middles == ends)  # no number lies between
            resolved_panels.append(panels.take(is_resolved))
            if np.all(is_resolved):
                break
            middles = middles[~is_resolved]
            begins = np.concatenate([begins[~is_resolved], middles])
            ends = np.concatenate([middles, ends[~is_resolved]])
        all_panels = _Panels._make(
            np.concatenate(column) for column in zip(*resolved_panels, strict=True)
        )
        return all_panels.take(np.argsort(all_panels.begin))

    def _panels_with_series(self, begins: Array, ends: Array) -> _Panels:
        """Panels of time (m,) with the Chebyshev series of the integrand, and its error, at the
        points that the edge of contact does not pass nearby; both are 0 at the others.
        """
        # For each pair of panel and point that has a series: its numbers and coefficients.
        far_series = self._far_series(begins, ends)
        far_pairs = (far_series.panel, far_series.point)
        table_shape = (len(begins), len(self._x))
        error_table = np.zeros(table_shape)
        error_table[far_pairs] = truncation_error(far_series.coefficients)
        coefficient_table = np.zeros((*table_shape, CHEBYSHEV_DEGREE + 1))
        coefficient_table[far_pairs] = far_series.coefficients
        return _Panels(begins, ends, far_series.is_near, coefficient_table, error_table)

    def _near_integrals(self, begins: Array, ends: Array, point_number: Indices) -> Array:
        """Integrals of the kernel times dQ over m ranges of time in which the edge of contact
        passes a point or nearly, (m,): range j from begins[j] to ends[j], at the point of number
        point_number[j].

        The variable of integration depends on the turning point of P, before or behind the arc. A
        range lies before or behind the middle of the arc and takes the turning point on its side.

        The kernel is the shear, slip or displacement by a unit tangential force on a flat punch. An
        arc is a part of a curved load segment, travelled in full stick.
        """
        integrals = np.empty(len(begins))
        is_behind_middle = begins >= self._middle_time
        for turning_point, is_on_side in (
            (self._turn_at_begin, ~is_behind_middle),
            (self._turn_at_end, is_behind_middle),
        ):
            near_integral = _NearIntegral(self._contact, self._kernel, self._segment, turning_point)
            points_on_side = point_number[is_on_side]
            # `_edge_loads`: load at which the edge of contact is at each point
            integrals[is_on_side] = near_integral.over_times(
                begins[is_on_side],
                ends[is_on_side],
                self._x[points_on_side],
                self._edge_loads[points_on_side],
            )
        return integrals

    def _far_series(self, begins: Array, ends: Array) -> _FarSeries:
        """Chebyshev series in time of the integrand dQ/dt K on panels of time (n,), for points that
        the edge of contact does not pass nearby; and a mask of the points that it does pass nearby.

        The kernel K is the shear, slip or displacement at the point by a unit tangential force on a
        flat punch. Where it is 0 all over a panel the point is neither far nor near.
        """
        is_far, is_near = self._far_and_near_points(begins, ends)
        far_panel, far_point = np.nonzero(is_far)
        # at the Chebyshev nodes of each panel, (n, nodes): time, P, and dQ/dt times the length
        panel_length = (ends - begins)[:, None]
        time = begins[:, None] + panel_length * (1 + CHEBYSHEV_NODES) / 2
        load = np.maximum(self._segment.loads(time)[0], 0.0)
        force_rate = self._segment.rate_of(TANGENTIAL_LOAD, time) * panel_length
        # what the kernels take for the contact half-width a(P)
        advance = self._contact.edge_advance(load)
        coefficients = np.empty((len(far_panel), CHEBYSHEV_DEGREE + 1))
        # Two million nodes at once bound the storage.
        pairs_at_once = _NODES_AT_ONCE // (CHEBYSHEV_DEGREE + 1)
        for first_pair in range(0, len(far_panel), pairs_at_once):
            chunk = slice(first_pair, first_pair + pairs_at_once)
            panel_chunk = far_panel[chunk]
            point_chunk = far_point[chunk]
            # `_edge_loads`: load at which the edge of contact is at each point
            kernel_values = _punch_kernel(
                self._contact,
                self._kernel,
                self._x[point_chunk, None],
                load[panel_chunk] - self._edge_loads[point_chunk, None],
                load[panel_chunk],
                advance[panel_chunk],
            )
            coefficients[chunk] = chebyshev_coefficients(force_rate[panel_chunk] * kernel_values)
        return _FarSeries(far_panel, far_point, coefficients, is_near)

    def _far_and_near_points(
        self, begins: Array, ends: Array
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether points are far from the edge of contact on panels of time (n,), and whether it
        passes them or nearly, (n, k) each. A point at which the kernel is 0 all over a panel is
        neither.

        P_x is the load at which the edge of contact is at a point. It is far from a panel where it
        lies outside the panel's loads by twice their range, on the side where the kernel is not 0.
        The slip kernel is not 0 where P < P_x, and has a logarithm at P = 0: next to P = 0 no point
        is far for it. The kernels of shear and displacement are not 0 where P > P_x.
        """
        edge_loads = self._edge_loads  # P_x
        # P grows along the arc.
        least_load = np.maximum(self._segment.loads(begins)[0], 0.0)[:, None]
        largest_load = np.maximum(self._segment.loads(ends)[0], 0.0)[:, None]
        far_distance = _RANGES_TO_FAR * (largest_load - least_load)
        if self._kernel == "slip":
            begins_near_no_load = least_load < far_distance
            is_near = (edge_loads > least_load) & (
                (edge_loads < largest_load + far_distance) | begins_near_no_load
            )
            is_far = (edge_loads >= largest_load + far_distance) & ~begins_near_no_load
        else:
            is_far = edge_loads <= least_load - far_distance
            is_near = (edge_loads < largest_load) & (edge_loads > least_load - far_distance)
        return np.asarray(is_far), np.asarray(is_near)


def _first_panel_ends(piece: Piece, corner_loads: Array) -> Array:
    """Ends of the panels of time into which an arc is cut at first, ascending (n,): 12 for all of
    it, and more where it passes corners of the profile.

    A smooth part lies between the times at which P had the loads of two corners. Its panels have
    equal lengths: one that began just behind a corner would not be smooth.

    Parameters
    ----------
    piece
        piece of the memory curve with the arc, a part of a curved load segment travelled in full
        stick: times of its ends (`arc_times`), and the instant at the end before any of the arc was
        cut off (`anchor`)
    corner_loads
        loads at which the edge of contact is at a corner, ascending
    """
    assert piece.arc_times is not None  # for the type checker: only called for arcs
    first_time = piece.arc_times[0]
    last_time = piece.anchor.time
    loads_within_arc = corner_loads[
        (corner_loads > piece.bottom_load) & (corner_loads < piece.anchor.normal_load)
    ]
    corner_times = loads_within_arc
    if len(loads_within_arc):
        corner_times = time_of_load_on_arc(piece, loads_within_arc)
    smooth_part_ends = np.unique(
        np.clip([first_time, *corner_times, last_time], first_time, last_time)
    )
    # 12 panels for all of the arc
    panels_in_smooth_part = np.maximum(
        np.ceil(np.diff(smooth_part_ends) / (last_time - first_time) * _FIRST_PANELS), 1
    ).astype(int)
    panel_begins = [
        np.linspace(part_begin, part_end, n_panels, endpoint=False)
        for part_begin, part_end, n_panels in zip(
            smooth_part_ends[:-1], smooth_part_ends[1:], panels_in_smooth_part, strict=True
        )
    ]
    # A smooth part that is hardly longer than round-off has no inner ends.
    return np.unique([*np.concatenate(panel_begins), last_time])


@lru_cache(maxsize=16)  # kernels and points of one solution share its arcs
def _turning_point(segment: LoadSegment, arc_end: float, other_end: float) -> TurningPoint:
    """The turning point of the load P(t) at one end of an arc, or beyond that end by less than the
    arc's duration; the end itself where there is none.

    An arc is the part of the load segment between the times `arc_end` and `other_end`, along which
    P grows in time. The turning point is found by Newton's method on dP/dt. The formulas of the
    segment hold beyond its ends too.
    """
    signed_duration = other_end - arc_end
    # P grows along the arc: a turning point at its begin is a least P (+1), at its end a largest
    # (-1).
    sign_of_turn = math.copysign(1.0, signed_duration)
    # d2P/dt2 from the rates a thousandth of the arc apart
    time_increment = 1e-3 * signed_duration
    turning_time = arc_end
    for _ in range(20):
        load_rate = float(segment.rate_of(NORMAL_LOAD, turning_time))
        rate_after = segment.rate_of(NORMAL_LOAD, turning_time + time_increment)
        rate_before = segment.rate_of(NORMAL_LOAD, turning_time - time_increment)
        second_derivative_of_load = float(rate_after - rate_before) / (2 * time_increment)
        newton_step = (
            load_rate / second_derivative_of_load
            if second_derivative_of_load * sign_of_turn > 0
            else math.inf
        )
        # A step that leads too far away, or into the arc: there is no turning point.
        is_too_far = abs(newton_step) > abs(signed_duration)
        if is_too_far or (arc_end - turning_time + newton_step) * sign_of_turn < -abs(
            time_increment
        ):
            return TurningPoint(arc_end, float(segment.loads(arc_end)[0]), sign_of_turn, other_end)
        turning_time -= newton_step
        if abs(newton_step) <= 1e-15 * (abs(turning_time) + abs(signed_duration)):
            break
    # Round-off may have led it into the arc.
    turning_time = min(turning_time, arc_end) if signed_duration > 0 else max(turning_time, arc_end)
    return TurningPoint(
        turning_time, float(segment.loads(turning_time)[0]), sign_of_turn, other_end
    )


def _force_rate_over_z(segment: LoadSegment, turning_point: TurningPoint, z: Array) -> Array:
    """Rate of Q over z = sqrt(|P - P_t|) along a load segment, |dQ/dz| with the sign of dQ/dt, at z
    of any shape; 0 where P rests. P_t is the load at the turning point of P.
    """
    # Time at which P has this z; then dQ/dz = (dQ/dt) 2 z/|dP/dt|.
    time = segment.time_of(
        NORMAL_LOAD, turning_point.sign * z * z, turning_point.time, turning_point.other_end_time
    )
    load_rate = np.abs(segment.rate_of(NORMAL_LOAD, time))
    force_rate = segment.rate_of(TANGENTIAL_LOAD, time)
    return np.asarray(force_rate * 2 * z / np.where(load_rate > 0, load_rate, np.inf))


def _punch_kernel(
    contact: Contact, kernel: Kernel, x: Array, load_above_edge: Array, load: Array, advance: Array
) -> Array:
    """Kernel K(x, P) at points `x`: shear, slip or displacement there by a unit tangential force on
    a flat punch of half-width a(P), over A/pi but for the shear; arrays of one shape.

        shear   1/sqrt(a^2 - x^2), pi times dp/dP
        slip    arccosh(|x|/a)
        shift   ln(2 L/a), the displacement

    Parameters
    ----------
    contact
        normal contact of the profile, which gives the kernels
    load_above_edge
        P - P_x, P_x the load at which the edge of contact is at x
    load, advance
        P; a(P) - a(0) [length], which the kernels take for a(P); of a tilted contact P itself

    # notation: A = 2/E*, L datum length of displacements
    """
    if kernel == "shear":
        return contact.inverse_root(x, load_above_edge, advance)
    if kernel == "slip":
        return contact.arccosh_ratio(x, -load_above_edge, advance)
    return contact.log_datum_ratio(load)


@dataclass(frozen=True, eq=False)
class _NearIntegral:
    """Integrals of one kernel K times dQ over ranges of time in which the edge of contact passes
    the point or nearly, or P is close to 0.

    P_x is the load at which the edge of contact is at the point; it is among the loads of the range
    or close to them. `turning_point` is the turning point of P next to the range, at or before its
    begin or at or behind its end.
    """

    contact: Contact
    kernel: Kernel
    segment: LoadSegment
    turning_point: TurningPoint

    @property
    def acts_beyond_e(self) -> bool:
        """Whether the kernel is not 0 for z^2 > e^2; else for z^2 < e^2. z^2 is the distance of P
        from its turning point, e^2 that of P_x.
        """
        return (self.kernel != "slip") == (self.turning_point.sign > 0)

    def over_times(self, begin_time: Array, end_time: Array, x: Array, edge_load: Array) -> Array:
        """Integrals of dQ/dt K(x, P(t)) over time, (m,), by Gauss' rule in a variable s in which
        the integrand is smooth, where the edge of contact passes the point or nearly.

        K is the shear, slip or displacement at x by a unit tangential force on a flat punch. Where
        K is not 0 for z^2 > e^2, s = ln(z + sqrt(z^2 - e^2)) but for a constant; where it is not
        for z^2 < e^2, s = arcsin(z/e).

        # notation: P_t load at the turning point of P, z^2 = |P - P_t|, P_x load at which the edge
        #           of contact is at x, e^2 = P_x - P_t beside a least P, P_t - P_x beside a largest

        Parameters
        ----------
        begin_time, end_time
            (m,) limits of the integrals, P monotonic from the turning point to both
        x, edge_load
            (m,) a point for each integral, and its P_x
        """
        if not len(begin_time):
            return np.zeros(0)
        # its `load` P_t; its sign, +1 beside a least P, -1 beside a largest
        turning_point = self.turning_point
        z_at_begin = self._z_at(begin_time)
        z_at_end = self._z_at(end_time)
        least_z = np.minimum(z_at_begin, z_at_end)
        largest_z = np.maximum(z_at_begin, z_at_end)
        squared_e = turning_point.sign * (edge_load - turning_point.load)
        # An e of 0 would stretch the variable for ever.
        least_square = 1e-36 * largest_z**2
        squared_e = np.where(np.abs(squared_e) < least_square, least_square, squared_e)
        # the part of each range where K is not 0, in s
        limit_function = _limits_beyond if self.acts_beyond_e else _limits_within
        begin_s, end_s = limit_function(least_z, largest_z, squared_e)
        return self._over_ranges_of_s(begin_s, end_s, x, squared_e)

    def _over_ranges_of_s(self, begin_s: Array, end_s: Array, x: Array, squared_e: Array) -> Array:
        """Integrals of dQ/ds K(x, P) over ranges of the integration variable s, (m,), each at its
        own point; 0 for a range without length. The integrand is smooth in s.

        K is the shear, slip or displacement at x by a unit tangential force on a flat punch. Gauss'
        rule takes the more nodes the longer a range is. A rule for singular ends replaces it in
        rough ranges, close to a logarithm of the slip kernel.

        Parameters
        ----------
        begin_s, end_s
            (m,) ends of the ranges
        x, squared_e
            (m,) the point, and e^2: the distance, with its sign, of P_x from the turning point of
            P. P_x is the load at which the edge of contact is at the point
        """
        is_rough = self._is_rough(begin_s, end_s - begin_s, squared_e)
        nodes = _nodes_of_ranges(begin_s, end_s, is_rough)
        integrals = np.zeros(len(begin_s))
        # Two million nodes at once bound the storage.
        for first_node in range(0, len(nodes.s), _NODES_AT_ONCE):
            chunk = slice(first_node, first_node + _NODES_AT_ONCE)
            range_number = nodes.range_number[chunk]
            integrand = self._integrand(nodes.s[chunk], x[range_number], squared_e[range_number])
            integrals += np.bincount(range_number, nodes.weight[chunk] * integrand, len(integrals))
        return integrals

    def _z_at(self, time: Array) -> Array:
        """z = sqrt(|P - P_t|) at times (m,), P_t the load at the turning point of P."""
        rise = self.segment.change_of(NORMAL_LOAD, time, self.turning_point.time)
        return np.sqrt(np.maximum(self.turning_point.sign * rise, 0.0))

    def _is_rough(self, begin_s: Array, s_length: Array, squared_e: Array) -> NDArray[np.bool_]:
        """Whether the integral over a range of the integration variable s needs the rule for
        singular ends, (m,); a range begins at `begin_s` and is `s_length` long.

        The slip kernel has a logarithm where P = 0, at s = +-i arsinh(sqrt(P_t)/e). Too close to it
        Gauss' rule fails: at four lengths 6 nodes leave 16^-12. P_t is the load at the turning
        point of P. `squared_e` = e^2 is the distance, with its sign, of P_x from P_t; P_x is the
        load at which the edge of contact is at the point. A displacement ("shift") takes that rule
        always: it has one point, and is cheap.
        """
        if self.kernel == "shift":
            return np.ones(len(begin_s), dtype=bool)
        # acts_beyond_e: whether the kernel is not 0 for z^2 > e^2, z^2 = |P - P_t|.
        if self.kernel != "slip" or self.acts_beyond_e:
            return np.zeros(len(begin_s), dtype=bool)
        # _LENGTHS_FROM_LOGARITHM: 4 lengths of the range.
        load_at_turn = max(self.turning_point.load, 0.0)
        least_squared_e = 1e-200 * load_at_turn + 1e-300
        distance_of_logarithm = np.arcsinh(
            np.sqrt(load_at_turn / np.maximum(squared_e, least_squared_e))
        )
        return np.asarray(
            np.hypot(begin_s, distance_of_logarithm) < _LENGTHS_FROM_LOGARITHM * s_length
        )

    def _integrand(self, s: Array, x: Array, squared_e: Array) -> Array:
        """Integrand dQ/ds K(x, P) at nodes s (n,) of the integration variable, each with its point
        x and its e^2, (n,).

        e^2 (`squared_e`) is the distance, with its sign, of P_x from P_t: P_x is the load at which
        the edge of contact is at x, P_t that at the turning point of P. Q is a function of z =
        sqrt(|P - P_t|) along the load path, and dz/ds = sqrt(|z^2 - e^2|).
        """
        z, dz_ds = _z_and_dz_ds(s, squared_e, self.acts_beyond_e)
        # P; what the kernels take for a(P), the contact half-width; P - P_x, of size |z^2 - e^2|,
        # negative for the slip.
        load = np.maximum(self.turning_point.load + self.turning_point.sign * z * z, 0.0)
        advance = self.contact.edge_advance(load)
        load_above_edge = dz_ds * dz_ds if self.kernel != "slip" else -dz_ds * dz_ds
        kernel_values = _punch_kernel(self.contact, self.kernel, x, load_above_edge, load, advance)
        return np.asarray(
            dz_ds * _force_rate_over_z(self.segment, self.turning_point, z) * kernel_values
        )


class _RangeNodes(NamedTuple):
    """Quadrature nodes s and weights of many ranges of a variable in one array, and the number of
    the range that each belongs to, (n,) each.
    """

    range_number: Indices
    s: Array
    weight: Array


def _nodes_of_ranges(begin_s: Array, end_s: Array, is_rough: NDArray[np.bool_]) -> _RangeNodes:
    """Quadrature nodes and weights for integrals over many ranges of a variable s, from `begin_s`
    to `end_s`, (m,) each, all in one array.

    Gauss' rule with as many nodes as the length of the range takes; the rule for singular ends
    where `is_rough`, (m,); none where a range has no length. One array for all, since a call for
    each rule would take longer than its arithmetic.
    """
    s_length = end_s - begin_s
    # _NODES_BY_LENGTH: longest range for each number of Gauss nodes
    gauss_rule_of_range = np.searchsorted(
        [longest_length for longest_length, _ in _NODES_BY_LENGTH], s_length
    )
    rough_ranges = np.flatnonzero((s_length > 0) & is_rough)
    # of each rule: numbers of its ranges, and nodes and weights, (ranges, nodes) each
    ranges_by_rule = [rough_ranges]
    nodes_by_rule = [graded_nodes(begin_s[rough_ranges], end_s[rough_ranges])]
    for rule_number, (_, n_nodes) in enumerate(_NODES_BY_LENGTH):
        ranges_of_rule = np.flatnonzero(
            (s_length > 0) & ~is_rough & (gauss_rule_of_range == rule_number)
        )
        if not len(ranges_of_rule):
            continue
        unit_nodes, unit_weights = gauss_rule(n_nodes)
        length_column = s_length[ranges_of_rule, None]
        ranges_by_rule.append(ranges_of_rule)
        nodes_by_rule.append(
            (
                begin_s[ranges_of_rule, None] + length_column * unit_nodes,
                length_column * unit_weights,
            )
        )
    range_of_nodes = [
        np.repeat(range_numbers, s.shape[1])
        for range_numbers, (s, _) in zip(ranges_by_rule, nodes_by_rule, strict=True)
    ]
    return _RangeNodes(
        np.concatenate(range_of_nodes),
        np.concatenate([s.ravel() for s, _ in nodes_by_rule]),
        np.concatenate([weights.ravel() for _, weights in nodes_by_rule]),
    )


def _limits_beyond(least_z: Array, largest_z: Array, squared_e: Array) -> tuple[Array, Array]:
    """Integration variable s at both ends of ranges from `least_z` to `largest_z`, (m,) each, for
    kernels that are not 0 where z^2 > e^2.

    s = arcosh(z/e), 0 up to z = e; for e^2 < 0 s = arsinh(z/|e|). z^2 is the distance of P from its
    turning point, `squared_e` = e^2 that of P_x with its sign; P_x is the load at which the edge of
    contact is at the point.
    """
    e = np.sqrt(np.abs(squared_e))

    def s_at(z_limit: Array) -> Array:
        """s at a limit of z."""
        z = np.where(squared_e > 0, np.maximum(z_limit, e), z_limit)
        # (z - e)(z + e), not z^2 - e^2: at z = e round-off would leave a root of 1e-8 in the
        # latter.
        root = np.sqrt(np.maximum((z - e) * (z + e), 0.0))
        return np.arcsinh(np.where(squared_e > 0, root, z) / np.maximum(e, 1e-300))

    begin = s_at(least_z)
    return begin, np.maximum(begin, s_at(largest_z))


def _limits_within(least_z: Array, largest_z: Array, squared_e: Array) -> tuple[Array, Array]:
    """Integration variable s = arcsin(z/e) at both ends of ranges from `least_z` to `largest_z`,
    (m,) each, for kernels that are not 0 where z^2 < e^2; equal where all of a range is outside.

    z^2 is the distance of P from its turning point, `squared_e` = e^2 that of P_x with its sign;
    P_x is the load at which the edge of contact is at the point.
    """
    e = np.sqrt(np.maximum(squared_e, 0.0))

    def s_at(z_limit: Array) -> Array:
        """s at a limit of z."""
        z = np.minimum(z_limit, e)
        return np.arctan2(z, np.sqrt((e - z) * (e + z)))

    begin = s_at(least_z)
    return begin, np.maximum(begin, s_at(largest_z))


def _z_and_dz_ds(s: Array, squared_e: Array, acts_beyond_e: bool) -> tuple[Array, Array]:
    """z and dz/ds = sqrt(|z^2 - e^2|) at values s of the integration variable, (n,) each: z > e if
    the kernel acts there (`acts_beyond_e`), else z < e.

    z^2 is the distance of P from its turning point, `squared_e` = e^2 that of P_x with its sign.
    P_x is the load at which the edge of contact is at the point.
    """
    e = np.sqrt(np.abs(squared_e))
    if not acts_beyond_e:
        return e * np.sin(s), e * np.cos(s)
    e_times_cosh = e * np.cosh(s)
    e_times_sinh = e * np.sinh(s)
    return np.where(squared_e > 0, e_times_cosh, e_times_sinh), np.where(
        squared_e > 0, e_times_sinh, e_times_cosh
    )


# Share of a load up to which a straight part of a memory curve is short: differences of slips keep
# 1e-15 of the slip from 0 on, over the power 3/2 of the share.
_SHARE_OF_SHORT_PART = 0.01


@dataclass(frozen=True, eq=False)
class KernelIntegrals:
    """Integrals of M'(eta) K(x, eta) d eta over memory curves at |x| = `x` (k,): shear, slip or
    displacement. What curves have in common is integrated once, and stored.

    The memory curve M(eta) is the tangential force that the flat punches up to the load eta carry.

    Attributes
    ----------
    contact
        normal contact of the profile
    x
        (k,) distances from the centre >= 0
    kernel
        "shear" (K = dp/d eta), "slip" (K = arccosh(|x|/a) outside, 0 inside) or "shift" (K =
        ln(2 L/a), the displacement; x plays no part)
    """

    contact: Contact
    x: Array
    kernel: Kernel
    # by the id of a piece: the piece, and the integral (k,) up to its top
    _stored: dict[int, tuple[CurvePart, Array]] = field(default_factory=dict)
    # by segment, begin and end of an arc: a piece of it, and its integrals
    _arcs: dict[tuple[int, float, float], tuple[Piece, ArcIntegrals]] = field(default_factory=dict)

    def over_memory_curves(self, snapshot: Snapshot) -> Array:
        """Shear q, slip s pi/A or displacement U pi/A of a contact at n instants and k points, (n,
        k): the integral of M'(eta) K(x, eta) over the memory curve of each instant; A = 2/E*.

        The memory curve M(eta) is the tangential force that the flat punches up to the load eta
        carry. K is the shear, slip or displacement by a unit tangential force on a flat punch. At
        constant P the shear is that of Cattaneo and Mindlin, q = f [p(x, P) - p(x, P - Q/f)].

        `snapshot` has the friction states at the instants: P, the load P - P_c of the slip zones,
        direction of slip, and the piece of the curve on which the stick edge P_c lies.

        >>> from scenes.segments import straight_segments
        >>> from semi_analytic.hertz import HertzContact
        >>> from semi_analytic.history import spans_along, snapshot_of
        >>> contact = HertzContact(modulus=np.pi, radius=1.0, datum_length=1.0)  # p(0, P) = sqrt(P)
        >>> loading, slip = spans_along(
        ...     None,
        ...     straight_segments([(0.0, 0.0, 0.0), (1.0, 4.0, 0.0), (2.0, 4.0, 1.5)]),
        ...     0.5,
        ...     0.0,
        ... )[0]
        >>> at_end = snapshot_of([(slip, np.array([2.0]))])  # M' = 0.5 from eta = 1 to P = 4
        >>> shear = KernelIntegrals(contact, np.zeros(1), "shear").over_memory_curves(at_end)
        >>> shear.round(12).tolist()  # 0.5 (sqrt 4 - sqrt 1)
        [[0.5]]
        >>> shift = KernelIntegrals(contact, np.zeros(1), "shift").over_memory_curves(at_end)
        >>> shift.round(12).tolist()  # U pi/A = 0.5 [4 ln(pi/2) + 2 - ln(pi) - 1/2], L = 1
        [[1.080800...]]
        """
        # P_c from P (`load`) and P - P_c
        stick_edge_load = snapshot.load - snapshot.slip_zone_load
        # of the piece of the curve that holds the stick edge: slope of its straight part, and eta
        # at its lower end
        slope_of_piece = np.zeros(len(snapshot.load))
        load_at_piece_bottom = np.zeros(len(snapshot.load))
        for piece, instants in snapshot.pieces_with_instants:
            slope_of_piece[instants] = piece.straight_slope
            load_at_piece_bottom[instants] = piece.bottom_load
        slope_in_slip_zones = np.asarray(snapshot.direction * snapshot.friction, dtype=float)

        # Slope +-f in the slip zones above the stick edge, the straight part of the piece below it.
        # In one call, since both need the kernel's integral up to the stick edge.
        straight_integrals = self._straight_integrals(
            np.concatenate([slope_in_slip_zones, slope_of_piece]),
            np.concatenate([stick_edge_load, load_at_piece_bottom]),
            np.concatenate([snapshot.load, stick_edge_load]),
        )
        integral_over_slip_zones, integral_over_piece = np.split(straight_integrals, 2)
        integrals = integral_over_slip_zones + integral_over_piece

        # The rest of the curve, below that piece, does not change while the piece stays.
        self._store_integrals([piece.curve_below for piece, _ in snapshot.pieces_with_instants])
        curved_integrals = self._curved_integrals(
            [
                (piece, stick_edge_load[instants])
                for piece, instants in snapshot.pieces_with_instants
            ]
        )
        for (piece, instants), curved_integral in zip(
            snapshot.pieces_with_instants, curved_integrals, strict=True
        ):
            integrals[instants] += self._stored_integral(piece.curve_below) + curved_integral
        return integrals

    def _stored_integral(self, curve: CurvePart | None) -> Array | float:
        """The stored integral of M' K over a memory curve up to the top of its uppermost piece,
        (k,); 0 of None, no curve.
        """
        return self._stored[id(curve)][1] if curve is not None else 0.0

    def _store_integrals(self, curves: Sequence[CurvePart | None]) -> None:
        """Integrate M' K over those memory curves that are not stored yet, and store the integral
        from 0 up to the top of each of their pieces, (k,).

        The memory curve M(eta) is the tangential force that the flat punches up to the load eta
        carry, K the kernel. A curve is given by its uppermost piece; each piece has the one below.
        Curves share their lower pieces: each curve is integrated upwards from its first piece that
        is already stored.
        """
        new_pieces: dict[int, CurvePart] = {}

        def is_not_stored(piece: CurvePart) -> bool:
            """Whether the piece is neither stored nor about to be."""
            return id(piece) not in self._stored and id(piece) not in new_pieces

        for curve in curves:
            pieces_to_store = list(takewhile(is_not_stored, pieces(curve)))
            # From the bottom up: the integral of a piece adds to that of the piece below.
            new_pieces.update({id(piece): piece for piece in reversed(pieces_to_store)})
        if not new_pieces:
            return

        # A piece is a straight line plus a curved remainder, between its bottom and its top load.
        slope_of_pieces = np.array([piece.straight_slope for piece in new_pieces.values()])
        loads_at_bottom = np.array([piece.bottom_load for piece in new_pieces.values()])
        loads_at_top = np.array([piece.top_load for piece in new_pieces.values()])
        straight_integrals = self._straight_integrals(
            slope_of_pieces, loads_at_bottom, loads_at_top
        )
        curved_integrals = self._curved_integrals(
            [(piece, np.array([piece.top_load])) for piece in new_pieces.values()]
        )

        # curve_below: the piece below, None at eta = 0.
        for piece, straight_integral, curved_integral in zip(
            new_pieces.values(), straight_integrals, curved_integrals, strict=True
        ):
            self._stored[id(piece)] = (
                piece,
                self._stored_integral(piece.curve_below)
                + straight_integral
                + np.ravel(curved_integral),
            )

    def _straight_integrals(self, slope: Array, lower_load: Array, upper_load: Array) -> Array:
        """Slope times the integral of K d eta over straight parts of memory curves, between two
        loads (n,), at each of k points: (n, k); 0 for parts without slope, or with equal loads.

        The memory curve M(eta) is the tangential force that the flat punches up to the load eta
        carry, K the kernel. The integral over a part is the difference of two integrals from 0 on.
        The slip of a short part, below 1 % of its load, is integrated over that part alone: its
        difference would be hardly more than round-off.
        """
        straight_integrals = np.zeros((len(upper_load), len(self.x)))
        part_numbers = np.flatnonzero((slope != 0) & (upper_load != lower_load))
        is_short = np.zeros(len(part_numbers), dtype=bool)
        if self.kernel == "slip" and isinstance(self.contact, PunchSuperposition):
            is_short = self._is_short_part(lower_load[part_numbers], upper_load[part_numbers])
        for parts, integrate in (
            (part_numbers[~is_short], self._difference_of_integrals),
            (part_numbers[is_short], self._short_slip_integrals),
        ):
            if len(parts):
                integrals = integrate(lower_load[parts], upper_load[parts])
                straight_integrals[parts] = slope[parts, None] * integrals
        return straight_integrals

    def _is_short_part(self, lower_load: Array, upper_load: Array) -> NDArray[np.bool_]:
        """Whether ranges between two loads (n,) are shorter than 1 % of the upper load, and neither
        contain nor closely follow the load of a corner of the profile, where a(P) is not smooth.
        """
        load_range = upper_load - lower_load
        corner_loads = self.contact.corner_loads
        n_corners_below_range = np.searchsorted(corner_loads, lower_load - load_range)
        n_corners_up_to_end = np.searchsorted(corner_loads, upper_load)
        is_within_share = load_range < _SHARE_OF_SHORT_PART * upper_load
        return np.asarray(is_within_share & (n_corners_below_range == n_corners_up_to_end))

    def _difference_of_integrals(self, lower_load: Array, upper_load: Array) -> Array:
        """Integral of the kernel K d eta between two loads, for n pairs of loads and at each of k
        points, (n, k), as a difference of two integrals from 0 on.
        """
        different_loads, number_in_loads = np.unique(
            np.concatenate([lower_load, upper_load]), return_inverse=True
        )
        # Each different load is integrated once: int K d eta from 0, (loads, k).
        integrals_from_0 = self.moment(0, different_loads)
        return np.asarray(
            integrals_from_0[number_in_loads[len(lower_load) :]]
            - integrals_from_0[number_in_loads[: len(lower_load)]]
        )

    def _short_slip_integrals(self, lower_load: Array, upper_load: Array) -> Array:
        """Integral of the slip kernel arccosh(|x|/a(eta)) d eta over short ranges of load (n,), at
        each of k points: (n, k), as one integral of positive terms; 0 for points in the contact.

        P_x is the load at which the edge of contact is at x; the integral ends there at the latest.
        With end = min(upper load, P_x), eta = end - v^2 and v = e sinh(s), e^2 = P_x - end >= 0,
        the root of P_x - eta becomes smooth.
        """
        contact = self.contact
        edge_loads = contact.load(self.x)
        # (n, k): upper limit, v at the lower load, and e
        end_load = np.minimum(upper_load[:, None], edge_loads)
        v_at_lower_load = np.sqrt(np.maximum(end_load - lower_load[:, None], 0.0))
        e_of_pairs = np.sqrt(np.maximum(edge_loads - end_load, 0.0))
        integrals = np.zeros(end_load.shape)
        # The range of s is the longer the nearer P_x is: it takes more nodes then.
        is_near = e_of_pairs < 0.5 * v_at_lower_load
        for is_in_group, n_nodes in ((~is_near, 12), (is_near, 32)):
            pairs = np.nonzero((v_at_lower_load > 0) & is_in_group)
            point_number = pairs[1]
            e = np.maximum(e_of_pairs[pairs], 1e-4 * v_at_lower_load[pairs])
            gauss_nodes, gauss_weights = gauss_rule(n_nodes)
            s_length = np.arcsinh(v_at_lower_load[pairs] / e)[:, None]
            v = e[:, None] * np.sinh(s_length * gauss_nodes)
            dv_ds = e[:, None] * np.cosh(s_length * gauss_nodes)
            # P_x - eta, and what the slip kernel takes for a(eta), the contact half-width
            load_below_edge = np.square(v) + np.square(e_of_pairs[pairs])[:, None]
            advance = contact.edge_advance(end_load[pairs][:, None] - np.square(v))
            arccosh_ratio = contact.arccosh_ratio(
                self.x[point_number, None], load_below_edge, advance
            )
            # d eta = 2 v dv
            integrals[pairs] = np.sum(
                gauss_weights * s_length * 2 * v * dv_ds * arccosh_ratio, axis=1
            )
        return integrals

    def _curved_integrals(
        self, pieces_and_upper_loads: Sequence[tuple[CurvePart, Array]]
    ) -> list[Array | float]:
        """What the curvature of pieces of memory curves adds to the integral of M' K d eta: (n, k)
        at k points for each pair of a piece and loads (n,). It is part of the shear, slip or
        displacement at the points. 0 for a straight piece; (n, 1) for the displacement along an
        arc, which is the same at all points.

        The memory curve M(eta) is the tangential force that the flat punches up to the load eta
        carry. K is the kernel: shear, slip or displacement by a unit load on a punch. M' is a
        constant slope, which is integrated elsewhere, plus a remainder that is integrated here,
        from the lower end of the piece to each load. A piece is straight, a parabola, or an arc, a
        part of a curved segment of the load path. Pieces cut from one arc begin at the same instant
        of it, and are integrated together.

        Parameters
        ----------
        pieces_and_upper_loads
            pairs of a piece and the loads (n,) up to which it counts: those at the stick edge if it
            is the uppermost piece that sticks, else its top load
        """
        integrals: list[Array | float] = [0.0] * len(pieces_and_upper_loads)
        # for each arc, by its segment, begin and end: its pieces, with the number of their pair
        pieces_of_arc: dict[tuple[int, float, float], list[tuple[int, Piece]]] = {}
        for pair_number, (piece, upper_load) in enumerate(pieces_and_upper_loads):
            if isinstance(piece, Piece) and piece.arc_times is not None:
                # `anchor`: instant at the end of the arc before any of it was cut off
                arc_key = (id(piece.anchor.segment), piece.arc_times[0], piece.anchor.time)
                pieces_of_arc.setdefault(arc_key, []).append((pair_number, piece))
                if arc_key not in self._arcs:
                    arc_integrals = ArcIntegrals(self.contact, self.kernel, piece, self.x)
                    self._arcs[arc_key] = piece, arc_integrals
            elif piece.bend:
                integrals[pair_number] = self._parabola_integral(piece, upper_load)
        for arc_key, numbered_pieces in pieces_of_arc.items():
            _, arc_integrals = self._arcs[arc_key]
            _, first_piece = numbered_pieces[0]
            upper_loads = [
                pieces_and_upper_loads[pair_number][1] for pair_number, _ in numbered_pieces
            ]
            integrals_of_pieces = self._integrals_up_to_loads(
                arc_integrals, first_piece, upper_loads
            )
            for (pair_number, _), integral_of_piece in zip(
                numbered_pieces, integrals_of_pieces, strict=True
            ):
                integrals[pair_number] = integral_of_piece
        return integrals

    def _parabola_integral(self, piece: CurvePart, upper_load: Array) -> Array:
        """Integral of 2 `bend` eta K d eta from the lower end of a piece to each load (n,), at k
        points, (n, k): what the curvature of a parabola adds, K the kernel.

        `bend` is the factor of eta^2 in the memory curve M(eta), the tangential force carried up to
        the load eta.
        """
        moment_change = self.moment(1, upper_load) - self.moment(1, np.array([piece.bottom_load]))
        return 2 * piece.bend * moment_change

    @staticmethod
    def _integrals_up_to_loads(
        arc: ArcIntegrals, piece: Piece, upper_loads: Sequence[Array]
    ) -> list[Array]:
        """Integrals of the kernel times dQ from the begin of an arc to the times at which P had
        each of the loads (n,) of several lists, (n, k) for each list. `piece` is one of the
        pieces that were cut from the arc.
        """
        times_at_upper_load = time_of_load_on_arc(piece, np.concatenate(upper_loads))
        split_positions = np.cumsum([len(loads_of_piece) for loads_of_piece in upper_loads])[:-1]
        return np.split(arc.up_to(times_at_upper_load), split_positions)

    @property
    def arc_error(self) -> float:
        """Largest estimated error of the integrals so far along arcs, curved pieces of a memory
        curve; 0 without arcs.
        """
        return max((arc.error for _, arc in self._arcs.values()), default=0.0)

    def moment(self, order: int, load: Array) -> Array:
        """Integral of eta^order K(x, eta) d eta from 0 to each load (n,), at each point x (k,): (n,
        k); `order` is 0 or 1. K is the kernel of shear, slip or displacement.
        """
        contact = self.contact
        load_column = load[:, None]
        if self.kernel == "shift":
            integral_function = (contact.approach_integral, contact.approach_moment)[order]
            return np.broadcast_to(integral_function(load_column), (len(load), len(self.x)))
        if self.kernel == "shear":
            # All moments are taken as differences between two loads.
            return (contact.pressure_rise, contact.pressure_moment)[order](self.x, load_column)
        return (contact.slip_integral, contact.slip_integral_moment)[order](self.x, load_column)
