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
from reports.scoring.loop_fit import Weights, nearest_on_polyline
from scenes import Scene
from scenes.array_types import Array

# Samples of the memory curve, closer towards gross sliding, where its slope grows as a logarithm,
# and how near they come to it.
_SAMPLES = 1001
_BEFORE_SLIDING = 1e-6
# Corners of a branch in the search for the nearest point; the distance itself is that from the
# curve.
_CORNERS = 160
# Corners on each side beyond the turning points: to a third of the range of Q.
_BEYOND = 18
# Step of a derivative by differences, of the parameter.
_SHARE_OF_STEP = 1e-4
# Places of the parameters.
LOG_F, MIDDLE, RANGE, COMPLIANCE, ORIGIN, DRIFT_RATE, SLIDE = range(7)


@dataclass(frozen=True, eq=False)
class MeasuredRows:
    """What a fit rests on.

    shift, load, time : (n,) U, Q and time of the rows
    branches : where they lie, by their order; its turning points are those of U and Q together,
        each over its range
    compliance : of the rig, None where it is fitted
    resolution : steps of U and Q that the digits of the rows resolve
    """

    shift: Array
    load: Array
    time: Array
    branches: Branches
    compliance: float | None
    resolution: tuple[float, float]

    @property
    def share_of_time(self) -> Array:
        """Of the record, from -1/2 to 1/2 (n,)."""
        passed = self.time - self.time[0]
        return np.asarray(passed / passed[-1] - 0.5)

    @functools.cached_property
    def beside_turns(self) -> NDArray[np.intp]:
        """The two rows at each turning point: either branch may be theirs."""
        rising = self.branches.rising
        changes = np.flatnonzero(rising[1:] != rising[:-1])
        return np.unique(np.concatenate([changes, changes + 1]))

    @functools.cached_property
    def instants_of_turns(self) -> tuple[float, float]:
        """Mean share of time of the highest and of the lowest turning points."""
        phase = np.maximum.accumulate(self.branches.phase)
        means = []
        for first in (0.5, 0.0):
            at = np.arange(math.ceil(phase[0] - first), phase[-1] - first + 1e-9) + first
            instants = np.interp(at, phase, self.share_of_time)
            means.append(float(np.mean(instants)) if len(at) else 0.0)
        return means[0], means[1]

    @property
    def ranges(self) -> tuple[float, float]:
        """Of U and of Q."""
        return float(np.ptp(self.shift)), float(np.ptp(self.load))

    @property
    def sizes(self) -> Array:
        """Typical sizes of the parameters (7,)."""
        of_load = float(np.ptp(self.load))
        of_shift = float(np.ptp(self.shift))
        return np.array([1.0, of_load, of_load, of_shift / of_load, of_shift, of_shift, of_shift])


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of rows from a loop, in the plane of U and Q, each over its sigma.

    value : (n,) in sigma, positive where U of the row is larger
    derivatives : (n, 7) by ln f, Q_mid, R, C, U_mid, D and S
    unit_normal : (n, 2) of the loop at the nearest point, in sigma of U and of Q
    place : (n,) of the nearest point, a parameter along the loop: 0 to 1 on the rising branch and
        its slide, 1 to 2 on the falling one
    """

    value: Array
    derivatives: Array
    unit_normal: Array
    place: Array


# ------------------------------------------------------------------------------------ its branches
@dataclass(frozen=True, eq=False)
class MemoryCurve:
    """u(h; f) = f v(h/f) at the scene's constant P: half-plane theory at samples, cubic between
    them.

    Below 0 and beyond gross sliding v goes on straight: noise takes rows there.
    """

    limit: float  # h/f of the last sample
    sliding: float  # f of gross sliding over the range of Q
    spline: Any
    slope: Any

    def value(self, h: Array) -> Array:
        """v [length] at h/f [force per thickness]."""
        inner = np.clip(h, 0.0, self.limit)
        before = np.minimum(h, 0.0) * self.slope(0.0)
        beyond = np.maximum(h - self.limit, 0.0) * self.slope(self.limit)
        return np.asarray(self.spline(inner) + before + beyond)

    def rate(self, h: Array) -> Array:
        """dv/dh [1/stress]."""
        return np.asarray(self.slope(np.clip(h, 0.0, self.limit)))


def memory_curve(scene: Scene, sliding_friction_over_range: float) -> MemoryCurve:
    """The memory curve u(h) of a scene at constant P, from one solve: U changes by 2 f u(h/f) when
    Q falls by 2 h from a turning point (Masing's rule). It is the falling branch of a loop that
    nearly slides as a whole.

    Parameters
    ----------
    sliding_friction_over_range
        f at which the scene just slides as a whole, over the range of its Q [1/load]
    """
    from scipy.interpolate import CubicSpline

    friction = scene.friction.coefficient
    path_of_scene = scene.load.path()
    normal_loads, _ = path_of_scene.at(np.array([path_of_scene.cycle_start]))
    normal_load = float(np.asarray(normal_loads)[0])
    largest_argument = normal_load * (1 - _BEFORE_SLIDING)
    largest_load = friction * largest_argument
    loads = {
        "kind": "polygon",
        "initial_loading": [(normal_load, 0.0), (normal_load, largest_load)],
        "cycle": [(normal_load, -largest_load)],
    }
    nearly_sliding = scene.vary(load=loads, cycles=2)
    path = nearly_sliding.load.path()
    assert path.period is not None
    # closer and closer towards gross sliding, where the slope grows
    share_of_branch = 1 - (1 - np.linspace(0.0, 1.0, _SAMPLES)) ** 3
    times = path.cycle_start + path.period * (1 + share_of_branch / 2)
    solution = semi_analytic.solve(
        nearly_sliding, x=0.0, time=times, fields="tangential_displacement", cycles="steady"
    )
    shift = solution.tangential_displacement
    spline = CubicSpline(largest_argument * share_of_branch, (shift[0] - shift) / (2 * friction))
    return MemoryCurve(largest_argument, sliding_friction_over_range, spline, spline.derivative())


# ----------------------------------------------------------------------------------------- the loop
@dataclass(frozen=True, eq=False)
class MasingLoop:
    """A loop of Masing's rule, by its seven parameters (7,): ln f, Q_mid, R, C, U_mid, D and S. Its
    points are those of the rising branch and its gross slide, from the middle of the loop on.

    Points have a place, a parameter along the branch: 0 to 1 in partial slip, closer towards the
    end, where the slope grows as a logarithm; 1 to 2 on the slide. Below 0 and above 2 the line
    goes on: noise takes rows beyond the turning points, and their distance from a turning point
    would draw it outwards.
    """

    curve: MemoryCurve
    parameters: Array

    @property
    def friction(self) -> float:
        """f."""
        return math.exp(self.parameters[LOG_F])

    @property
    def _slides(self) -> bool:
        return bool(self.parameters[SLIDE] > 0)

    def _fraction_of_load_range(self, place: Array) -> Array:
        """Fraction of the range of Q that the rising branch has passed at places (n,)."""
        inside = 1 - (1 - np.clip(place, 0.0, 1.0)) ** 3
        passed = inside + 3 * np.minimum(place, 0.0)
        if not self._slides:
            passed = passed + 3 * np.maximum(place - 2, 0.0)
        return np.asarray(passed)

    def points(self, place: Array) -> tuple[Array, Array]:
        """U and Q of the rising branch of the loop, (n,) each, counted from the middle of the loop.

        `place` (n,) numbers the points of the branch: 0 to 1 in partial slip, 1 to 2 while the
        contact slides as a whole. Past 2 the branch goes on with the slope of its end, so that a
        row of data beyond it has a nearest point: along U where the contact slides, else along Q.
        """
        fraction_of_range = self._fraction_of_load_range(place)
        friction = self.friction
        half_range = self.parameters[RANGE] / 2
        shift_at_turn = friction * self.curve.value(np.array(half_range / friction))
        shift_from_turn = 2 * friction * self.curve.value(fraction_of_range * half_range / friction)
        shift_of_slide = self.parameters[SLIDE] * (np.clip(place - 1, 0.0, 1.0) - 0.5)
        if self._slides:
            shift_past_end = 2 * shift_at_turn * np.maximum(place - 2, 0.0)
            shift_of_slide = shift_of_slide + shift_past_end
        load = (2 * fraction_of_range - 1) * half_range
        shift = (
            shift_from_turn - shift_at_turn + shift_of_slide + self.parameters[COMPLIANCE] * load
        )
        return shift, load

    def closed(self, share: Array) -> tuple[Array, Array]:
        """U and Q from the middle of the loop at shares of a cycle (n,), from the highest Q on."""
        on_falling = share < 0.5
        place = np.clip(np.where(on_falling, share, share - 0.5) * 4, 0.0, 2.0)
        shift, load = self.points(place)
        side = np.where(on_falling, -1.0, 1.0)
        return side * shift, side * load

    def at_rows(self, place: Array) -> tuple[Array, Array]:
        """U and Q from the middle of the loop at places of rows, from 0 to 2 (`Distances`)."""
        on_falling = place > 1
        shift, load = self.points(2 * np.where(on_falling, place - 1, place))
        side = np.where(on_falling, -1.0, 1.0)
        return side * shift, side * load

    @property
    def area(self) -> float:
        """W, by twice as many chords."""
        areas = []
        for count in (2001, 4001):
            shift, load = self.closed(np.linspace(0.0, 1.0, count))
            areas.append(float(np.sum((load[1:] + load[:-1]) / 2 * np.diff(shift))))
        return areas[1] + (areas[1] - areas[0]) / 3

    @property
    def area_by_friction_where_gross(self) -> float:
        """Derivative of W by f, with which R goes."""
        gradient = self.area_by_parameters
        by_log = gradient[LOG_F] + self.parameters[RANGE] * gradient[RANGE]
        return float(by_log) / self.friction

    @property
    def area_by_parameters(self) -> Array:
        """Derivatives of W by the parameters (7,)."""
        gradient = np.zeros(7)
        for k in (LOG_F, RANGE, COMPLIANCE, SLIDE):
            step = np.zeros(7)
            step[k] = _SHARE_OF_STEP * max(abs(float(self.parameters[k])), _SHARE_OF_STEP)
            above = MasingLoop(self.curve, self.parameters + step).area
            below = MasingLoop(self.curve, self.parameters - step).area
            gradient[k] = (above - below) / (2 * step[k])
        return gradient

    def with_friction(self, friction: float) -> MasingLoop | None:
        """The gross loop of another f with the same range of U; None where that f does not slide
        in it.
        """
        end = np.array([2.0])
        parameters = self.parameters.copy()
        parameters[LOG_F] = math.log(friction)
        parameters[RANGE] = friction / self.curve.sliding
        missing = float(
            self.points(end)[0][0] - MasingLoop(self.curve, parameters).points(end)[0][0]
        )
        parameters[SLIDE] += 2 * missing
        return MasingLoop(self.curve, parameters) if parameters[SLIDE] > 0 else None

    def tangents(self, place: Array) -> tuple[Array, Array]:
        """Direction in U and Q at places (n,), of any length."""
        on_branch = (place < 1) | (not self._slides)
        rate = self.curve.rate(
            self._fraction_of_load_range(place) * self.parameters[RANGE] / 2 / self.friction
        )
        of_shift = np.where(on_branch, rate + self.parameters[COMPLIANCE], 1.0)
        return of_shift, on_branch.astype(float)

    def derivatives(self, place: Array) -> tuple[Array, Array]:
        """Derivatives of U and of Q of the rising branch at places (n,) by the seven parameters of
        the loop, (n, 7) each: ln f, middle and range R of Q, compliance C of the rig, origin of U,
        drift of U, gross slide S. Those by the middle of Q, the origin of U and the drift are left
        0.

        With h half of the load since the turning point, U = 2 f v(h/f) - f v(R/2f) + ... (Masing's
        rule). `place` is that of `points`.
        """
        fraction_of_range = self._fraction_of_load_range(place)
        friction = self.friction
        half_range = self.parameters[RANGE] / 2
        # h/f, the argument of the memory curve v
        load_over_friction_at_turn = np.array(half_range / friction)
        load_over_friction = fraction_of_range * half_range / friction
        slope_at_turn = self.curve.rate(load_over_friction_at_turn)
        slope_at_place = self.curve.rate(load_over_friction)
        shift_derivatives = np.zeros((len(place), 7))
        load_derivatives = np.zeros((len(place), 7))
        # d(f v(h/f))/df = v - (h/f) v'
        shift_by_friction = 2 * (
            self.curve.value(load_over_friction) - load_over_friction * slope_at_place
        )
        shift_by_friction -= (
            self.curve.value(load_over_friction_at_turn)
            - load_over_friction_at_turn * slope_at_turn
        )
        shift_derivatives[:, LOG_F] = friction * shift_by_friction
        load_derivatives[:, RANGE] = fraction_of_range - 0.5
        shift_by_range = fraction_of_range * slope_at_place - slope_at_turn / 2
        shift_derivatives[:, RANGE] = shift_by_range + self.parameters[COMPLIANCE] * (
            fraction_of_range - 0.5
        )
        shift_derivatives[:, COMPLIANCE] = (2 * fraction_of_range - 1) * half_range
        shift_derivatives[:, SLIDE] = np.clip(place - 1, 0.0, 1.0) - 0.5
        return shift_derivatives, load_derivatives


# The slide is parted too: the nearest corner is beside the nearest point where neighbouring pieces
# are about as long.
_PLACES = np.arange(-_BEYOND, 2 * _CORNERS + _BEYOND + 1) / _CORNERS


def distances_from(
    rows: MeasuredRows, curve: MemoryCurve, parameters: Array, weights: Weights
) -> Distances:
    """Distances of the rows of a measured loop from the loop of Masing's rule with the seven
    `parameters`, over sigma, with their derivatives by these. A row beside a turning point is
    measured from the nearer of both branches.

    Parameters
    ----------
    rows
        U, Q, time and branch of each row
    curve
        memory curve of theory, from which the loop is built
    parameters
        (7,) ln f, middle and range of Q, compliance C of the rig, origin of U, drift of U, gross
        slide
    weights
        sigma of U and of Q
    """
    loop = MasingLoop(curve, parameters)
    shift = rows.shift - parameters[ORIGIN] - parameters[DRIFT_RATE] * rows.share_of_time
    load = rows.load - parameters[MIDDLE]
    corners_of_branch = np.array(loop.points(_PLACES))
    corners_of_branch /= np.array(weights)[:, None]
    branch_sign = np.where(rows.branches.rising, 1.0, -1.0)
    answers_by_own_branch = _distances_from_branch(
        loop, corners_of_branch, shift, load, branch_sign, weights
    )
    rows_beside_turns = rows.beside_turns
    answers_by_other_branch = _distances_from_branch(
        loop,
        corners_of_branch,
        shift[rows_beside_turns],
        load[rows_beside_turns],
        -branch_sign[rows_beside_turns],
        weights,
    )
    other_is_nearer = np.abs(answers_by_other_branch[0]) < np.abs(
        answers_by_own_branch[0][rows_beside_turns]
    )
    # where the other branch is nearer: distance, unit normal and place are those of it
    for answer_of_rows, answer_of_other in zip(
        answers_by_own_branch, answers_by_other_branch, strict=True
    ):
        answer_of_rows[rows_beside_turns[other_is_nearer]] = answer_of_other[other_is_nearer]
    branch_sign[rows_beside_turns[other_is_nearer]] *= -1

    distance, unit_shift, unit_load, place = answers_by_own_branch
    shift_derivatives, load_derivatives = loop.derivatives(place)
    shift_derivatives *= branch_sign[:, None]
    load_derivatives *= branch_sign[:, None]
    shift_derivatives[:, ORIGIN] = 1.0
    shift_derivatives[:, DRIFT_RATE] = rows.share_of_time
    load_derivatives[:, MIDDLE] = 1.0
    derivatives = -unit_shift[:, None] * shift_derivatives / weights.shift
    derivatives -= unit_load[:, None] * load_derivatives / weights.load
    place_on_branch = np.clip(place, 0.0, 2.0) / 2
    return Distances(
        value=distance,
        derivatives=derivatives,
        unit_normal=np.column_stack([unit_shift, unit_load]),
        place=np.where(branch_sign > 0, place_on_branch, 1 + place_on_branch),
    )


def _distances_from_branch(
    loop: MasingLoop,
    polygon: Array,
    shift: Array,
    load: Array,
    branch_sign: Array,
    weights: Weights,
) -> tuple[Array, Array, Array, Array]:
    """Distances of rows from one branch of the loop, in sigma, positive where U of the row is
    larger; the components in U and in Q of the unit normal there; and the places of the nearest
    points on the branch, (n,) each (see `MasingLoop.points`).

    The nearest point of the polygon gives the place. The distance is that from the tangent of the
    true branch there.

    Parameters
    ----------
    polygon
        (2, m) points of the rising branch, over sigma, at the places `_PLACES`
    shift, load
        (n,) U and Q of the rows, from the middle of the loop
    branch_sign
        (n,) 1 for rows of the rising branch, -1 for the falling one, which is the rising one turned
        about the middle
    weights
        sigma of U and Q
    """
    row_points = np.array([branch_sign * shift / weights.shift, branch_sign * load / weights.load])
    place_on_polygon, _, _, _ = nearest_on_polyline(row_points, polygon)
    place = (place_on_polygon - _BEYOND) / _CORNERS
    # The branch has no tangent where the slide begins (a kink), nor at its two ends, which lie
    # beyond the turning points.
    is_at_kink = (place_on_polygon <= 0) | (place == 1) | (place_on_polygon >= len(_PLACES) - 1)
    if not loop.parameters[SLIDE] > 0:
        is_at_kink &= place != 1

    loop_point = loop.points(place)
    shift_from_loop = row_points[0] - loop_point[0] / weights.shift
    load_from_loop = row_points[1] - loop_point[1] / weights.load
    tangent_shift, tangent_load = loop.tangents(place)
    tangent_shift = tangent_shift / weights.shift
    tangent_load = tangent_load / weights.load
    tangent_length = np.hypot(tangent_shift, tangent_load)
    unit_shift = tangent_load / tangent_length
    unit_load = -tangent_shift / tangent_length
    distance = shift_from_loop * unit_shift + load_from_loop * unit_load

    # There the distance is that from the point; its sign is that across the branch.
    distance_from_point = np.hypot(shift_from_loop, load_from_loop)
    is_at_kink &= distance_from_point > 0
    signed_distance = np.where(distance < 0, -distance_from_point, distance_from_point)
    divisor = np.where(is_at_kink, signed_distance, 1.0)
    unit_shift = np.where(is_at_kink, shift_from_loop / divisor, unit_shift)
    unit_load = np.where(is_at_kink, load_from_loop / divisor, unit_load)
    distance = np.where(is_at_kink, signed_distance, distance)
    return branch_sign * distance, unit_shift, unit_load, place
