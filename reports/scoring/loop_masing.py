"""The loop of Masing's rule, where P is constant: by its f, turning points, rig, drift and gross
slide; and how far rows lie from it.

# notation: C compliance of the rig, D drift of U over time, f friction coefficient, h load since a
#           turning point over 2, Q_mid middle of Q, R range of Q, S gross slide of U at each end,
#           sigma standard deviation of the noise of a row, U_mid U at the middle of the loop,
#           v(h/f) U of the initial loading over f

A branch hangs on its turning point (Masing's rule), and the falling one is the rising one turned
about the middle of the loop:

    Q = Q_mid - R/2 + 2 h,   U = -f v(R/2f) - S/2 + 2 f v(h/f) + C (Q - Q_mid) + U_mid + D t.

A partial loop has S = 0 and R < 2 f P. A gross loop has R = 2 f P: at its ends Q stays at its
plateau while U moves on by S. The two meet at S = 0, R = 2 f P. Rows have distances from
the nearest points of the loop, in sigma of U and of Q; `loop_masing_fit` makes them least.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.scoring.loop_branches import Branches
from reports.scoring.loop_fit import RowNoise, nearest_on_polyline
from scenes import Scene
from scenes.array_types import Array

# Samples of the memory curve, closer towards gross sliding, where its slope grows as a logarithm,
# and how far from it they end, over f P.
_N_SAMPLES_OF_CURVE = 1001
_RELATIVE_DISTANCE_TO_SLIDING = 1e-6
# Corners of the polygon in which the nearest point is sought, in each part of a branch: partial
# slip and slide. The distance itself is that from the curve.
_CORNERS_PER_PART = 160
# Corners beyond each of the two turning points: to a third of the range of Q.
_CORNERS_BEYOND_TURN = 18
# Step of a derivative by differences, over the parameter.
_RELATIVE_STEP = 1e-4
# Indices of the seven parameters of a loop: ln f, Q_mid, R, C, U_mid, D and S.
LOG_F, MIDDLE, RANGE, COMPLIANCE, ORIGIN, DRIFT_RATE, SLIDE = range(7)


@dataclass(frozen=True, eq=False)
class MeasuredRows:
    """The measured rows to which a loop is fitted.

    displacement, load, time : (n,) U, Q and time of the rows
    branches : branch of each row, by their order; its turning points are those of the height
        U/(range of U) + Q/(range of Q)
    compliance : C of the rig [1/stress], None where it is fitted
    resolution : steps of U and Q that the digits of the rows resolve
    """

    displacement: Array
    load: Array
    time: Array
    branches: Branches
    compliance: float | None
    resolution: tuple[float, float]

    @property
    def share_of_time(self) -> Array:
        """Time of the rows over that of the whole record, from -1/2 to 1/2 (n,)."""
        time_passed = self.time - self.time[0]
        return np.asarray(time_passed / time_passed[-1] - 0.5)

    @functools.cached_property
    def rows_beside_turns(self) -> NDArray[np.intp]:
        """Indices of the two rows at each turning point, which may lie on either branch."""
        is_rising = self.branches.is_rising
        last_rows_of_branches = np.flatnonzero(is_rising[1:] != is_rising[:-1])
        return np.unique(np.concatenate([last_rows_of_branches, last_rows_of_branches + 1]))

    @functools.cached_property
    def mean_times_of_turns(self) -> tuple[float, float]:
        """Mean time of the highest and of the lowest turning points of the measured loop, over the
        time of the whole record, from -1/2 to 1/2; 0 without any such point.
        """
        # (n,) number of cycles since a lowest point, steps back by noise taken out: whole at lowest
        # points, a half more at highest ones
        ascending_cycles_passed = np.maximum.accumulate(self.branches.cycles_passed)
        mean_times = []
        for cycles_at_turn in (0.5, 0.0):
            first_cycle = math.ceil(ascending_cycles_passed[0] - cycles_at_turn)
            cycles = np.arange(first_cycle, ascending_cycles_passed[-1] - cycles_at_turn + 1e-9)
            # self.share_of_time: (n,) time of the rows over the record, from -1/2 to 1/2
            shares_of_time = np.interp(
                cycles + cycles_at_turn, ascending_cycles_passed, self.share_of_time
            )
            mean_times.append(float(np.mean(shares_of_time)) if len(shares_of_time) else 0.0)
        return mean_times[0], mean_times[1]

    @property
    def ranges(self) -> tuple[float, float]:
        """Range of U and range of Q, highest minus lowest."""
        return float(np.ptp(self.displacement)), float(np.ptp(self.load))

    @property
    def parameter_sizes(self) -> Array:
        """Typical sizes of the seven parameters of a loop, (7,), by which steps of a fit are
        scaled: of ln f, middle and range of Q, compliance of the rig, origin and drift of U, gross
        slide.

        # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
        """
        # of the rows, highest minus lowest; the sizes stand in the order of the parameters
        range_of_displacement, range_of_load = self.ranges
        return np.array(
            [
                1.0,
                range_of_load,
                range_of_load,
                range_of_displacement / range_of_load,
                range_of_displacement,
                range_of_displacement,
                range_of_displacement,
            ]
        )


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of rows from a loop, in the plane of U and Q, each over its sigma.

    signed_distance : (n,) in sigma, positive where U of the row is larger than U of the loop
    derivatives : (n, 7) of the distances by ln f, Q_mid, R, C, U_mid, D and S
    unit_normal : (n, 2) of the loop at the nearest point, in sigma of U and of Q
    place_on_loop : (n,) of the nearest point, a parameter along the loop: 0 to 1 on the rising
        branch and its slide, 1 to 2 on the falling one
    """

    signed_distance: Array
    derivatives: Array
    unit_normal: Array
    place_on_loop: Array


# ------------------------------------------------------------------------------------ its branches
@dataclass(frozen=True, eq=False)
class MemoryCurve:
    """The memory curve v(h/f), from which every branch of a loop at constant P follows: U of the
    initial loading is f v(h/f) at Q = h. Half-plane theory at samples, cubic between them.

    Below 0 and beyond gross sliding v is continued as a straight line: noise takes rows there.

    largest_argument : h/f of the last sample, just below gross sliding [force per thickness]
    sliding_friction_per_load : f at which the contact just slides as a whole, over the range of Q
    spline, spline_slope : v and dv/d(h/f) between 0 and the largest argument
    """

    largest_argument: float
    sliding_friction_per_load: float
    spline: Any
    spline_slope: Any

    def value(self, argument: Array) -> Array:
        """Memory curve v(h/f) [length] at `argument` = h/f [force per thickness]. Below 0 and
        beyond the last sample, just below gross sliding, it goes on as a straight line.
        """
        argument_on_spline = np.clip(argument, 0.0, self.largest_argument)
        value_below_zero = np.minimum(argument, 0.0) * self.spline_slope(0.0)
        argument_beyond = np.maximum(argument - self.largest_argument, 0.0)
        value_beyond = argument_beyond * self.spline_slope(self.largest_argument)
        return np.asarray(self.spline(argument_on_spline) + value_below_zero + value_beyond)

    def slope(self, argument: Array) -> Array:
        """dv/d(h/f) [1/stress] at `argument` = h/f."""
        return np.asarray(self.spline_slope(np.clip(argument, 0.0, self.largest_argument)))


def memory_curve(scene: Scene, sliding_friction_per_load: float) -> MemoryCurve:
    """The memory curve v(h/f) of a scene at constant P, from one solve of half-plane theory: U
    falls by 2 f v(h/f) when Q falls by 2 h from a turning point (Masing's rule). Every branch of a
    loop follows from it. It is taken from the falling branch of a loop that nearly slides as a
    whole, on which h/f runs from 0 to nearly P.

    Parameters
    ----------
    sliding_friction_per_load
        f at which the scene just slides as a whole, over the range of its Q [1/load]; it is
        stored with the curve

    # notation: f coefficient of friction, P and Q loads, U relative tangential displacement
    """
    from scipy.interpolate import CubicSpline

    friction_coefficient = scene.friction.coefficient
    path_of_scene = scene.load.path()
    normal_loads, _ = path_of_scene.at(np.array([path_of_scene.cycle_start]))
    normal_load = float(np.asarray(normal_loads)[0])
    # of h/f: a millionth of P below gross sliding
    largest_argument = normal_load * (1 - _RELATIVE_DISTANCE_TO_SLIDING)
    largest_tangential_load = friction_coefficient * largest_argument
    nearly_sliding_loads = {
        "kind": "polygon",
        # vertices (P, Q)
        "initial_loading": [(normal_load, 0.0), (normal_load, largest_tangential_load)],
        "cycle": [(normal_load, -largest_tangential_load)],
    }
    nearly_sliding_scene = scene.vary(load=nearly_sliding_loads, cycles=2)
    nearly_sliding_path = nearly_sliding_scene.load.path()
    assert nearly_sliding_path.period is not None
    # samples closer and closer towards gross sliding, where the slope grows
    share_of_branch = 1 - (1 - np.linspace(0.0, 1.0, _N_SAMPLES_OF_CURVE)) ** 3
    # second cycle, whose first half is the falling branch
    times = nearly_sliding_path.cycle_start + nearly_sliding_path.period * (1 + share_of_branch / 2)
    solution = semi_analytic.solve(
        nearly_sliding_scene, x=0.0, time=times, fields="tangential_displacement", cycles="steady"
    )
    displacement = solution.tangential_displacement
    memory_values = (displacement[0] - displacement) / (2 * friction_coefficient)
    spline = CubicSpline(largest_argument * share_of_branch, memory_values)
    return MemoryCurve(largest_argument, sliding_friction_per_load, spline, spline.derivative())


# ----------------------------------------------------------------------------------------- the loop
@dataclass(frozen=True, eq=False)
class MasingLoop:
    """A loop of Masing's rule, by its seven parameters (7,): ln f, Q_mid, R, C, U_mid, D and S. U
    and Q of its points are counted from the middle of the loop.

    Points of the rising branch have a place, a parameter along it: 0 to 1 in partial slip, closer
    towards the end, where the slope grows as a logarithm; 1 to 2 on the slide. Below 0 and above 2
    the branch is continued: noise takes rows beyond the turning points, and their distance from a
    turning point would draw it outwards.
    """

    curve: MemoryCurve
    parameters: Array

    @property
    def friction(self) -> float:
        """Coefficient of friction f."""
        return math.exp(self.parameters[LOG_F])

    @property
    def _has_slide(self) -> bool:
        """Whether the loop is gross: the contact slides as a whole at its ends."""
        return bool(self.parameters[SLIDE] > 0)

    def _fraction_of_load_range(self, place: Array) -> Array:
        """Fraction of the range of Q that the rising branch of the loop has passed at places (n,),
        (n,). A place is a parameter along the branch: 0 at the lower turning point, 1 at the end of
        partial slip, 2 at the end of gross sliding. The fraction is 1 − (1 − place)^3 from 0 to 1,
        and 1 on the slide.

        Below place 0 it is continued as a straight line; above 2 as well where the loop has no
        slide.

        # notation: Q tangential load
        """
        fraction_on_branch = 1 - (1 - np.clip(place, 0.0, 1.0)) ** 3
        fraction_of_range = fraction_on_branch + 3 * np.minimum(place, 0.0)
        # slide: the contact slides as a whole at the ends of the loop
        if not self._has_slide:
            fraction_of_range = fraction_of_range + 3 * np.maximum(place - 2, 0.0)
        return np.asarray(fraction_of_range)

    def points(self, place: Array) -> tuple[Array, Array]:
        """U and Q of the rising branch of the loop, (n,) each, counted from the middle of the loop.

        `place` (n,) is a parameter along the branch: 0 to 1 in partial slip, 1 to 2 while the
        contact slides as a whole. Past 2 the branch is continued, so that a row beyond its end has
        a nearest point: along U where the contact slides, else along the memory curve v.

            U = 2 f v(h/f) - f v(R/2f) + slide + C Q,

        with h half of the rise of Q since the lower turning point.

        # notation: C compliance of the rig, f friction coefficient, R range of Q, v memory curve of
        #           theory, `self.curve.value`; RANGE, SLIDE, COMPLIANCE: indices of R, slide and C,
        #           Q tangential load, U relative tangential displacement
        """
        # fraction of R that is passed: 0 at the lower turning point, 1 at the upper one
        fraction_of_range = self._fraction_of_load_range(place)
        friction = self.friction
        half_range = self.parameters[RANGE] / 2
        displacement_at_turn = friction * self.curve.value(np.array(half_range / friction))
        displacement_from_turn = (
            2 * friction * self.curve.value(fraction_of_range * half_range / friction)
        )
        displacement_of_slide = self.parameters[SLIDE] * (np.clip(place - 1, 0.0, 1.0) - 0.5)
        # gross: the contact slides as a whole at the ends of the loop
        if self._has_slide:
            # any slope will do, here the range of U in partial slip per unit of place
            displacement_past_end = 2 * displacement_at_turn * np.maximum(place - 2, 0.0)
            displacement_of_slide = displacement_of_slide + displacement_past_end
        load = (2 * fraction_of_range - 1) * half_range
        displacement_of_rig = self.parameters[COMPLIANCE] * load
        displacement = (
            displacement_from_turn
            - displacement_at_turn
            + displacement_of_slide
            + displacement_of_rig
        )
        return displacement, load

    def closed_curve(self, share_of_cycle: Array) -> tuple[Array, Array]:
        """U and Q around the whole loop, (n,) each, counted from its middle, at shares of a cycle
        (n,) from 0 to 1: the falling branch first, from the highest Q on.
        """
        is_falling = share_of_cycle < 0.5
        share_of_branch = 2 * np.where(is_falling, share_of_cycle, share_of_cycle - 0.5)
        # of the rising branch, at places 0 to 2 along it
        displacement, load = self.points(np.clip(2 * share_of_branch, 0.0, 2.0))
        # the falling branch is the rising one rotated about the middle
        sign_of_branch = np.where(is_falling, -1.0, 1.0)
        return sign_of_branch * displacement, sign_of_branch * load

    def points_at_rows(self, place_on_loop: Array) -> tuple[Array, Array]:
        """U and Q from the middle of the loop at places of rows (n,): 0 to 1 on the rising branch,
        1 to 2 on the falling one (`Distances.place_on_loop`).
        """
        is_falling = place_on_loop > 1
        share_of_branch = np.where(is_falling, place_on_loop - 1, place_on_loop)
        displacement, load = self.points(2 * share_of_branch)
        # the falling branch is the rising one rotated about the middle
        sign_of_branch = np.where(is_falling, -1.0, 1.0)
        return sign_of_branch * displacement, sign_of_branch * load

    @property
    def area(self) -> float:
        """Area W of the loop, the closed integral of Q dU [energy per thickness], by 2,000 and by
        4,000 chords: the error, which falls with the square of their number, is extrapolated.
        """
        areas = []
        for n_points in (2001, 4001):
            # U and Q around the loop, at shares of the cycle from 0 to 1
            displacement, load = self.closed_curve(np.linspace(0.0, 1.0, n_points))
            areas.append(float(np.sum((load[1:] + load[:-1]) / 2 * np.diff(displacement))))
        return areas[1] + (areas[1] - areas[0]) / 3

    @property
    def area_by_friction_where_gross(self) -> float:
        """Derivative of W by f of a gross loop, whose range R = 2 f P grows with f."""
        gradient = self.area_by_parameters
        area_by_log_friction = gradient[LOG_F] + self.parameters[RANGE] * gradient[RANGE]
        return float(area_by_log_friction) / self.friction

    @property
    def area_by_parameters(self) -> Array:
        """Derivatives of the area W of the loop, the closed integral of Q dU, by its seven
        parameters (7,), by central differences. W does not depend on the middle of Q, the origin of
        U and the drift of U. `LOG_F`, `RANGE`, `COMPLIANCE` and `SLIDE` are indices of ln f, range
        of Q, compliance of the rig and gross slide.

        # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
        """
        gradient = np.zeros(7)
        for k in (LOG_F, RANGE, COMPLIANCE, SLIDE):
            parameter_step = np.zeros(7)
            # 1e-4 of the parameter
            parameter_step[k] = _RELATIVE_STEP * max(abs(float(self.parameters[k])), _RELATIVE_STEP)
            area_above = MasingLoop(self.curve, self.parameters + parameter_step).area
            area_below = MasingLoop(self.curve, self.parameters - parameter_step).area
            gradient[k] = (area_above - area_below) / (2 * parameter_step[k])
        return gradient

    def gross_loop_with_friction(self, friction: float) -> MasingLoop | None:
        """A gross loop with another coefficient of friction f over the same range of U: the contact
        slides the part of this range that it does not slip. None where this range is too short for
        a slide.

        The range of Q is R = 2 f P. `LOG_F`, `RANGE` and `SLIDE` are indices of ln f, R and slide
        among the seven parameters of a loop.

        # notation: P normal load, Q tangential load, R range of Q, U relative tangential
        #           displacement
        """
        # places 0 to 2 lie along the rising branch; 2 is the upper turning point
        place_of_end = np.array([2.0])
        parameters = self.parameters.copy()
        parameters[LOG_F] = math.log(friction)
        # sliding_friction_per_load: f at which the contact just slides as a whole, over R
        parameters[RANGE] = friction / self.curve.sliding_friction_per_load
        displacement_at_end, _ = self.points(place_of_end)
        displacement_with_same_slide, _ = MasingLoop(self.curve, parameters).points(place_of_end)
        missing_displacement = float(displacement_at_end[0] - displacement_with_same_slide[0])
        # half of the slide lies on each side of the middle of the loop
        parameters[SLIDE] += 2 * missing_displacement
        return MasingLoop(self.curve, parameters) if parameters[SLIDE] > 0 else None

    def tangents(self, place: Array) -> tuple[Array, Array]:
        """Components in U and in Q of a tangent to the rising branch of the loop at places (n,),
        (n,) each: (dU/dQ, 1) in partial slip, (1, 0) on the slide.

        `place` is a parameter along the branch: 0 to 1 in partial slip, 1 to 2 on the slide.
        `RANGE` and `COMPLIANCE` are the indices of the range of Q and of the rig's compliance.

        # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
        """
        # a loop without slide is in partial slip past its end too
        is_in_partial_slip = (place < 1) | (not self._has_slide)
        # slope of the memory curve v at h/f, h half of the rise of Q since the lower turning
        # point
        theory_slope = self.curve.slope(
            self._fraction_of_load_range(place) * self.parameters[RANGE] / 2 / self.friction
        )
        tangent_displacement = np.where(
            is_in_partial_slip, theory_slope + self.parameters[COMPLIANCE], 1.0
        )
        return tangent_displacement, is_in_partial_slip.astype(float)

    def derivatives(self, place: Array) -> tuple[Array, Array]:
        """Derivatives of U and of Q of the rising branch at places (n,) by the seven parameters of
        the loop, (n, 7) each: ln f, middle and range R of Q, compliance C of the rig, origin of U,
        drift of U, gross slide S. Those by the middle of Q, the origin of U and the drift are left
        0.

        With h half of the rise of Q since the lower turning point (Masing's rule),

            U = 2 f v(h/f) - f v(R/2f) + slide + C Q.

        `place` is a parameter along the branch: 0 to 1 in partial slip, 1 to 2 on the slide. v is
        the memory curve of theory, `self.curve.value`, with slope v', `self.curve.slope`. `LOG_F`,
        `RANGE`, `COMPLIANCE` and `SLIDE` are indices of parameters.

        # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
        """
        # fraction of R that the branch has passed: 0 at the lower turning point, 1 at the upper one
        fraction_of_range = self._fraction_of_load_range(place)
        friction = self.friction
        half_range = self.parameters[RANGE] / 2
        # h/f, the argument of the memory curve v
        load_over_friction_at_turn = np.array(half_range / friction)
        load_over_friction = fraction_of_range * half_range / friction
        slope_at_turn = self.curve.slope(load_over_friction_at_turn)
        slope_at_place = self.curve.slope(load_over_friction)

        displacement_derivatives = np.zeros((len(place), 7))
        load_derivatives = np.zeros((len(place), 7))
        # d(f v(h/f))/df = v - (h/f) v'
        displacement_by_friction = 2 * (
            self.curve.value(load_over_friction) - load_over_friction * slope_at_place
        )
        displacement_by_friction -= (
            self.curve.value(load_over_friction_at_turn)
            - load_over_friction_at_turn * slope_at_turn
        )
        displacement_derivatives[:, LOG_F] = friction * displacement_by_friction
        load_derivatives[:, RANGE] = fraction_of_range - 0.5
        displacement_by_range = fraction_of_range * slope_at_place - slope_at_turn / 2
        displacement_derivatives[:, RANGE] = displacement_by_range + self.parameters[COMPLIANCE] * (
            fraction_of_range - 0.5
        )
        displacement_derivatives[:, COMPLIANCE] = (2 * fraction_of_range - 1) * half_range
        displacement_derivatives[:, SLIDE] = np.clip(place - 1, 0.0, 1.0) - 0.5
        return displacement_derivatives, load_derivatives


# Places of the corners. Those of the slide too: the nearest corner lies beside the nearest point
# where neighbouring chords are about as long.
_PLACES_OF_CORNERS = (
    np.arange(-_CORNERS_BEYOND_TURN, 2 * _CORNERS_PER_PART + _CORNERS_BEYOND_TURN + 1)
    / _CORNERS_PER_PART
)


def distances_from_loop(
    rows: MeasuredRows, curve: MemoryCurve, parameters: Array, sigma: RowNoise
) -> Distances:
    """Distances of the rows of a measured loop from the loop of Masing's rule with the seven
    `parameters`, over sigma, with their derivatives by these. A row beside a turning point is
    measured from the nearer of both branches.

    Parameters
    ----------
    rows
        U, Q and branch of each row; `share_of_time`, its time over that of the record, from -1/2 to
        1/2; `rows_beside_turns`, indices of the two rows at each turning point
    curve
        memory curve of theory, from which the loop is built
    parameters
        (7,) ln f, middle and range of Q, compliance C of the rig, origin of U, drift of U, gross
        slide; MIDDLE, ORIGIN and DRIFT_RATE are indices of them
    sigma
        standard deviation of the noise of U and of Q, by which both are divided

    Returns
    -------
    Distances
        distance (n,), positive where U of the row is the larger; its derivatives (n, 7); unit
        normal (n, 2) of the loop; place of the nearest point on the loop, 0 to 1 on the rising and
        1 to 2 on the falling branch

    # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
    """
    loop = MasingLoop(curve, parameters)
    # U and Q of the rows, from the middle of the loop
    displacement_from_middle = (
        rows.displacement - parameters[ORIGIN] - parameters[DRIFT_RATE] * rows.share_of_time
    )
    load_from_middle = rows.load - parameters[MIDDLE]
    # corners (2, m) of a polygon along the rising branch, at 160 places in its partial slip and 160
    # on its slide (_PLACES_OF_CORNERS)
    corners_of_branch = np.array(loop.points(_PLACES_OF_CORNERS))
    corners_of_branch /= np.array(sigma)[:, None]
    branch_sign = np.where(rows.branches.is_rising, 1.0, -1.0)
    # (4, n) each: distance; components in U and in Q of the unit normal; place on the branch
    nearest_on_branch = _distances_from_branch(
        loop, corners_of_branch, displacement_from_middle, load_from_middle, branch_sign, sigma
    )

    # the other branch, for rows beside a turning point
    rows_beside_turns = rows.rows_beside_turns
    nearest_on_other_branch = _distances_from_branch(
        loop,
        corners_of_branch,
        displacement_from_middle[rows_beside_turns],
        load_from_middle[rows_beside_turns],
        -branch_sign[rows_beside_turns],
        sigma,
    )
    is_other_nearer = np.abs(nearest_on_other_branch[0]) < np.abs(
        nearest_on_branch[0, rows_beside_turns]
    )
    rows_of_other_branch = rows_beside_turns[is_other_nearer]
    nearest_on_branch[:, rows_of_other_branch] = nearest_on_other_branch[:, is_other_nearer]
    branch_sign[rows_of_other_branch] *= -1

    # place on the branch: 0 to 1 in partial slip and 1 to 2 on the slide
    distance, unit_normal_in_displacement, unit_normal_in_load, place_on_branch = nearest_on_branch
    displacement_derivatives, load_derivatives = loop.derivatives(place_on_branch)
    displacement_derivatives *= branch_sign[:, None]
    load_derivatives *= branch_sign[:, None]
    displacement_derivatives[:, ORIGIN] = 1.0
    displacement_derivatives[:, DRIFT_RATE] = rows.share_of_time
    load_derivatives[:, MIDDLE] = 1.0
    # a loop that moves along its normal, towards the row, shortens the distance
    derivatives = (
        -unit_normal_in_displacement[:, None] * displacement_derivatives / sigma.of_displacement
    )
    derivatives -= unit_normal_in_load[:, None] * load_derivatives / sigma.of_load
    share_of_branch = np.clip(place_on_branch, 0.0, 2.0) / 2
    return Distances(
        signed_distance=distance,
        derivatives=derivatives,
        unit_normal=np.column_stack([unit_normal_in_displacement, unit_normal_in_load]),
        place_on_loop=np.where(branch_sign > 0, share_of_branch, 1 + share_of_branch),
    )


def _distances_from_branch(
    loop: MasingLoop,
    corners_of_branch: Array,
    displacement_from_middle: Array,
    load_from_middle: Array,
    branch_sign: Array,
    sigma: RowNoise,
) -> Array:
    """Distances of measured rows from one branch of a loop of Q over U, (4, n): the distance in
    sigma, positive where U of the row is larger; the components in U and in Q of the unit normal at
    the nearest point of the branch; and the place of this point, a parameter along the branch: 0 to
    1 in partial slip, 1 to 2 on the slide.

    The nearest point of a polygon gives the place. The distance is that from the tangent of the
    true branch there; where the branch has none (a kink or an end), from the point itself.

    Parameters
    ----------
    loop
        its branches; `parameters[SLIDE]` is the gross slide, 0 in partial slip
    corners_of_branch
        (2, m) U and Q of the corners of a polygon along the rising branch, over sigma. Between
        neighbours the place grows by 1/160 (`_CORNERS_PER_PART`); 18 corners lie before place 0 and
        18 behind place 2
    displacement_from_middle, load_from_middle
        (n,) U and Q of the rows, from the middle of the loop
    branch_sign
        (n,) 1 for rows of the rising branch, -1 for the falling one, which is the rising one
        rotated about the middle of the loop
    sigma
        standard deviation of the noise of U and of Q

    # notation: Q tangential load, U relative tangential displacement
    """
    row_points = np.array(
        [
            branch_sign * displacement_from_middle / sigma.of_displacement,
            branch_sign * load_from_middle / sigma.of_load,
        ]
    )
    # index of the chord plus the fraction of it that is passed
    place_on_polygon, _, _, _ = nearest_on_polyline(row_points, corners_of_branch)
    place = (place_on_polygon - _CORNERS_BEYOND_TURN) / _CORNERS_PER_PART
    # The branch has no tangent where the slide begins (a kink), nor at the two ends of the polygon,
    # which lie beyond the turning points.
    has_no_tangent = (
        (place_on_polygon <= 0) | (place == 1) | (place_on_polygon >= len(_PLACES_OF_CORNERS) - 1)
    )
    if not loop.parameters[SLIDE] > 0:
        has_no_tangent &= place != 1

    # U and Q at the place, from the middle of the loop
    displacement_of_loop, load_of_loop = loop.points(place)
    displacement_from_loop = row_points[0] - displacement_of_loop / sigma.of_displacement
    load_from_loop = row_points[1] - load_of_loop / sigma.of_load
    tangent_in_displacement, tangent_in_load = loop.tangents(place)
    tangent_in_displacement = tangent_in_displacement / sigma.of_displacement
    tangent_in_load = tangent_in_load / sigma.of_load
    tangent_length = np.hypot(tangent_in_displacement, tangent_in_load)
    unit_normal_in_displacement = tangent_in_load / tangent_length
    unit_normal_in_load = -tangent_in_displacement / tangent_length
    distance = (
        displacement_from_loop * unit_normal_in_displacement + load_from_loop * unit_normal_in_load
    )

    # without a tangent: the distance from the point, with the sign that it has across the branch
    distance_from_point = np.hypot(displacement_from_loop, load_from_loop)
    has_no_tangent &= distance_from_point > 0
    signed_distance = np.where(distance < 0, -distance_from_point, distance_from_point)
    divisor = np.where(has_no_tangent, signed_distance, 1.0)
    unit_normal_in_displacement = np.where(
        has_no_tangent, displacement_from_loop / divisor, unit_normal_in_displacement
    )
    unit_normal_in_load = np.where(has_no_tangent, load_from_loop / divisor, unit_normal_in_load)
    distance = np.where(has_no_tangent, signed_distance, distance)
    return np.array(
        [branch_sign * distance, unit_normal_in_displacement, unit_normal_in_load, place]
    )
