"""The f, the turning points, the rig, the drift and the gross slide at which the loop of Masing's
rule follows the rows of a measured one, where P is constant.

# notation: C compliance of the rig, D drift of U over time, f friction coefficient, h load since a
#           turning point over 2, Q_mid middle of Q, R range of Q, S gross slide of U at each end,
#           sigma standard deviation of the noise of a row, U_mid U at the middle of the loop,
#           v(h/f) U of the initial loading over f

A branch hangs on its turning point (Masing's rule), and the falling one is the rising one turned
about the middle of the loop:

    Q = Q_mid - R/2 + 2 h,   U = -f v(R/2f) - S/2 + 2 f v(h/f) + C (Q - Q_mid) + U_mid + D t.

A partial loop has S = 0 and R < 2 f P. A gross loop has R = 2 f P: at its ends Q stays at its
plateau while U moves on by S. The two meet at S = 0, R = 2 f P. Least squares over all of these of
the distances of the rows from the nearest points of the loop, in sigma of U and of Q; the interval
of f is where the least sum of squares at a given f exceeds the least of all by what chance gives in
95 % (profile likelihood, with the F distribution since sigma is estimated from the rows).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.scoring.loop_branches import Branches, row_noise
from reports.scoring.loop_fit import Weights, nearest_on_line
from reports.scoring.loop_steadiness import Misfit, misfit_of
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
# First trials of f, from just above gross sliding to so many times as much; beyond, a loop is a
# line. Trials of the slide, in ranges of U.
_TRIALS = 24
_ABOVE = 0.002
_WIDEST = 40.0
_SLIDES = (0.05, 0.2, 0.4, 0.6, 0.8)
# Minima among the trials of each kind from which a fit begins.
_MINIMA = 2
# A gauge drifts by so much of the range of U over the record (standard deviation): what rows of one
# cycle can't tell from f.
_DRIFT = 0.02
# Least error of a turning point of U and Q together, each over its range: parabolas describe a
# branch beside it no better.
_ERROR_OF_TURN = 0.002
# Mean square of distances, in variances of the last digits, up to which digits alone explain them.
_BY_DIGITS = 1.3
# Mean of a half cycle in standard deviations beyond which its rows lie on another loop.
_RUN_IN_SEEN = 3.0
# Fits with the noise of the fit before: it changes by less than a part in twenty then.
_REWEIGHTED = 8
_SAME_NOISE = 0.05
# Largest scatter of ln(sigma of U/sigma of Q) about what neighbouring rows show.
_RATIO_OF_NOISE = 1.0
# Its scatter by chance, times the square root of rows, from the medians of both.
_OF_ROW_NOISE = 3.0
# Noise of rows that show none, over their largest value: f is not known better than theory's
# samples leave it.
_LEAST_NOISE = 1e-9
# Steps outwards to the end of an interval, and by which it is narrowed then.
_STEPS = 30
_NARROWED = 12
# Lowest and highest f of an interval over the best one.
_FARTHEST = 60.0
# Share of a step of the digits of Q within which a plateau lies in 95 %, where no noise moves it
# from one digit to the next; noise of that share of a step does.
_OF_STEP = 0.475
_MOVES_DIGITS = 0.4

# Places of the parameters.
_LOG_F, _MIDDLE, _RANGE, _COMPLIANCE, _ORIGIN, _DRIFT_RATE, _SLIDE = range(7)


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
    """Of rows from a loop.

    value : (n,) in sigma, positive where U of the row is larger
    derivatives : (n, 7) by ln f, Q_mid, R, C, U_mid, D and S
    across : (n, 2) unit vector across the loop, in sigma of U and of Q
    place : (n,) on the loop, 0 to 1 along the rising branch and its slide, 1 to 2 along the falling
        one
    """

    value: Array
    derivatives: Array
    across: Array
    place: Array


@dataclass(frozen=True, eq=False)
class MasingFit:
    """The loop that follows the rows best.

    Attributes
    ----------
    friction, low, high
        f and its 95 % interval; high None where no larger f can be told from it
    values
        (7,) ln f, Q_mid, R, C, U_mid, D over the record, S
    errors
        (7,) their standard errors
    gross
        whether the contact slides as a whole at the ends
    weights
        sigma of U and of Q
    distances
        of the rows
    misfit
        what the distances show
    """

    friction: float
    low: float
    high: float | None
    values: Array
    errors: Array
    gross: bool
    weights: Weights
    distances: Distances
    misfit: Misfit

    @property
    def highest(self) -> float:
        """Largest Q."""
        return float(self.values[_MIDDLE] + self.values[_RANGE] / 2)

    @property
    def lowest(self) -> float:
        """Smallest Q."""
        return float(self.values[_MIDDLE] - self.values[_RANGE] / 2)

    @property
    def compliance(self) -> float:
        """C [1/stress]."""
        return float(self.values[_COMPLIANCE])

    @property
    def drift(self) -> float:
        """D over the whole record [length]."""
        return float(self.values[_DRIFT_RATE])

    @property
    def drift_error(self) -> float:
        """Standard error of D [length]."""
        return float(self.errors[_DRIFT_RATE])

    @property
    def slide(self) -> float:
        """S [length]."""
        return float(self.values[_SLIDE])


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


def memory_curve(scene: Scene, sliding: float) -> MemoryCurve:
    """The curve from the falling branch of a loop that nearly slides: u(h) is half of U(Q_max) -
    U(Q_max - 2 h).

    Parameters
    ----------
    sliding
        f of gross sliding over the range of Q, of the scene
    """
    from scipy.interpolate import CubicSpline

    friction = scene.friction.coefficient
    path = scene.load.path()
    load = float(np.asarray(path.at(np.array([path.cycle_start]))[0])[0])
    limit = load * (1 - _BEFORE_SLIDING)
    largest = friction * limit
    loads = {
        "kind": "polygon",
        "initial_loading": [(load, 0.0), (load, largest)],
        "cycle": [(load, -largest)],
    }
    wave = scene.vary(load=loads, cycles=2)
    path = wave.load.path()
    assert path.period is not None
    passed = 1 - (1 - np.linspace(0.0, 1.0, _SAMPLES)) ** 3
    times = path.cycle_start + path.period * (1 + passed / 2)
    solution = semi_analytic.solve(
        wave, x=0.0, time=times, fields="tangential_displacement", cycles="steady"
    )
    shift = solution.tangential_displacement
    spline = CubicSpline(limit * passed, (shift[0] - shift) / (2 * friction))
    return MemoryCurve(limit, sliding, spline, spline.derivative())


# ----------------------------------------------------------------------------------------- the loop
@dataclass(frozen=True, eq=False)
class MasingLoop:
    """The rising branch for given parameters (7,), without rig, drift and middle; then its slide.

    Points have a place: 0 to 1 on the branch, closer towards its end, where the slope grows as a
    logarithm; 1 to 2 on the slide. Below 0 and above 2 the line goes on: noise takes rows beyond
    the turning points, and their distance from a turning point would draw it outwards.
    """

    curve: MemoryCurve
    values: Array

    @property
    def friction(self) -> float:
        """f."""
        return math.exp(self.values[_LOG_F])

    @property
    def _slides(self) -> bool:
        return bool(self.values[_SLIDE] > 0)

    def _passed(self, place: Array) -> Array:
        """Share of the branch in Q at places (n,)."""
        inside = 1 - (1 - np.clip(place, 0.0, 1.0)) ** 3
        passed = inside + 3 * np.minimum(place, 0.0)
        if not self._slides:
            passed = passed + 3 * np.maximum(place - 2, 0.0)
        return np.asarray(passed)

    def points(self, place: Array) -> tuple[Array, Array]:
        """U and Q from the middle of the loop at places (n,)."""
        passed = self._passed(place)
        friction = self.friction
        half = self.values[_RANGE] / 2
        at_turn = friction * self.curve.value(np.array(half / friction))
        from_turn = 2 * friction * self.curve.value(passed * half / friction)
        slid = self.values[_SLIDE] * (np.clip(place - 1, 0.0, 1.0) - 0.5)
        if self._slides:
            slid = slid + 2 * at_turn * np.maximum(place - 2, 0.0)
        load = (2 * passed - 1) * half
        return from_turn - at_turn + slid + self.values[_COMPLIANCE] * load, load

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

    def with_friction(self, friction: float) -> MasingLoop | None:
        """The gross loop of another f with the same range of U; None where that f does not slide
        in it.
        """
        end = np.array([2.0])
        values = self.values.copy()
        values[_LOG_F] = math.log(friction)
        values[_RANGE] = friction / self.curve.sliding
        missing = float(self.points(end)[0][0] - MasingLoop(self.curve, values).points(end)[0][0])
        values[_SLIDE] += 2 * missing
        return MasingLoop(self.curve, values) if values[_SLIDE] > 0 else None

    def tangents(self, place: Array) -> tuple[Array, Array]:
        """Direction in U and Q at places (n,), of any length."""
        on_branch = (place < 1) | (not self._slides)
        rate = self.curve.rate(self._passed(place) * self.values[_RANGE] / 2 / self.friction)
        of_shift = np.where(on_branch, rate + self.values[_COMPLIANCE], 1.0)
        return of_shift, on_branch.astype(float)

    def derivatives(self, place: Array) -> tuple[Array, Array]:
        """Of `points` by the parameters, but the middle and the drift: (n, 7) each."""
        passed = self._passed(place)
        friction = self.friction
        half = self.values[_RANGE] / 2
        at_turn = np.array(half / friction)
        at_place = passed * half / friction
        rate_at_turn = self.curve.rate(at_turn)
        rate = self.curve.rate(at_place)
        of_shift = np.zeros((len(place), 7))
        of_load = np.zeros((len(place), 7))
        by_friction = 2 * (self.curve.value(at_place) - at_place * rate)
        by_friction -= self.curve.value(at_turn) - at_turn * rate_at_turn
        of_shift[:, _LOG_F] = friction * by_friction
        of_load[:, _RANGE] = passed - 0.5
        by_range = passed * rate - rate_at_turn / 2
        of_shift[:, _RANGE] = by_range + self.values[_COMPLIANCE] * (passed - 0.5)
        of_shift[:, _COMPLIANCE] = (2 * passed - 1) * half
        of_shift[:, _SLIDE] = np.clip(place - 1, 0.0, 1.0) - 0.5
        return of_shift, of_load


# The slide is parted too: the nearest corner is beside the nearest point where neighbouring pieces
# are about as long.
_PLACES = np.arange(-_BEYOND, 2 * _CORNERS + _BEYOND + 1) / _CORNERS


def distances_from(
    rows: MeasuredRows, curve: MemoryCurve, values: Array, weights: Weights
) -> Distances:
    """Of rows from the loop of parameters (7,); beside a turning point from the nearer branch."""
    loop = MasingLoop(curve, values)
    shift = rows.shift - values[_ORIGIN] - values[_DRIFT_RATE] * rows.share_of_time
    load = rows.load - values[_MIDDLE]
    corners = np.array(loop.points(_PLACES))
    corners /= np.array(weights)[:, None]
    side = np.where(rows.branches.rising, 1.0, -1.0)
    found = _from_branch(loop, corners, shift, load, side, weights)
    beside = rows.beside_turns
    other = _from_branch(loop, corners, shift[beside], load[beside], -side[beside], weights)
    nearer = np.abs(other[0]) < np.abs(found[0][beside])
    for values_of_rows, values_of_other in zip(found, other, strict=True):
        values_of_rows[beside[nearer]] = values_of_other[nearer]
    side[beside[nearer]] *= -1

    distance, across_shift, across_load, place = found
    of_shift, of_load = loop.derivatives(place)
    of_shift *= side[:, None]
    of_load *= side[:, None]
    of_shift[:, _ORIGIN] = 1.0
    of_shift[:, _DRIFT_RATE] = rows.share_of_time
    of_load[:, _MIDDLE] = 1.0
    derivatives = -across_shift[:, None] * of_shift / weights.shift
    derivatives -= across_load[:, None] * of_load / weights.load
    along = np.clip(place, 0.0, 2.0) / 2
    return Distances(
        value=distance,
        derivatives=derivatives,
        across=np.column_stack([across_shift, across_load]),
        place=np.where(side > 0, along, 1 + along),
    )


def _from_branch(
    loop: MasingLoop, corners: Array, shift: Array, load: Array, side: Array, weights: Weights
) -> tuple[Array, Array, Array, Array]:
    """Distances (n,) of rows from the rising branch (side 1) or the falling one (-1), the unit
    vector across it in U and in Q, and places; in sigma.
    """
    points = np.array([side * shift / weights.shift, side * load / weights.load])
    index, _, _, _ = nearest_on_line(points, corners)
    place = (index - _BEYOND) / _CORNERS
    # Where the slide begins the line has a corner; it has ends beyond the turning points.
    at_end = (index <= 0) | (place == 1) | (index >= len(_PLACES) - 1)
    if not loop.values[_SLIDE] > 0:
        at_end &= place != 1

    on_loop = loop.points(place)
    apart_shift = points[0] - on_loop[0] / weights.shift
    apart_load = points[1] - on_loop[1] / weights.load
    tangent_shift, tangent_load = loop.tangents(place)
    tangent_shift = tangent_shift / weights.shift
    tangent_load = tangent_load / weights.load
    length = np.hypot(tangent_shift, tangent_load)
    across_shift = tangent_load / length
    across_load = -tangent_shift / length
    distance = apart_shift * across_shift + apart_load * across_load

    # At a corner or an end the distance is that from the point; its sign is that across the branch.
    from_end = np.hypot(apart_shift, apart_load)
    at_end &= from_end > 0
    signed = np.where(distance < 0, -from_end, from_end)
    divisor = np.where(at_end, signed, 1.0)
    across_shift = np.where(at_end, apart_shift / divisor, across_shift)
    across_load = np.where(at_end, apart_load / divisor, across_load)
    distance = np.where(at_end, signed, distance)
    return side * distance, across_shift, across_load, place


# ------------------------------------------------------------------------------------------ the fit
class _Least(NamedTuple):
    """Least sum of squares, and the parameters (7,) that give it."""

    squares: float
    values: Array


@dataclass(frozen=True, eq=False)
class _Search:
    """Least squares of the distances of rows, and of the drift."""

    rows: MeasuredRows
    curve: MemoryCurve
    weights: Weights

    @property
    def sizes(self) -> Array:
        return self.rows.sizes

    def residuals(self, values: Array) -> tuple[Array, Array]:
        """Distances, turning points and the drift, each over its sigma (n + 3,), and derivatives
        (n + 3, 7).
        """
        found = distances_from(self.rows, self.curve, values, self.weights)
        turns, of_turns = self._turning_points(values)
        drift = 1 / (_DRIFT * float(np.ptp(self.rows.shift)))
        of_drift = np.zeros((1, 7))
        of_drift[0, _DRIFT_RATE] = drift
        return (
            np.concatenate([found.value, turns, [values[_DRIFT_RATE] * drift]]),
            np.concatenate([found.derivatives, of_turns, of_drift]),
        )

    def _turning_points(self, values: Array) -> tuple[Array, Array]:
        """Of U and Q together, as those of the rows are found: (2,) in their sigma, and (2, 7)."""
        rows = self.rows
        loop = MasingLoop(self.curve, values)
        end = np.array([2.0])
        shift, load = loop.points(end)
        of_shift, of_load = loop.derivatives(end)
        range_of_shift, range_of_load = rows.ranges
        residuals = np.zeros(2)
        derivatives = np.zeros((2, 7))
        turns = (rows.branches.highest, rows.branches.lowest)
        for k, (turn, side, instant) in enumerate(
            zip(turns, (1.0, -1.0), rows.instants_of_turns, strict=True)
        ):
            of_shift_here = side * of_shift[0]
            of_shift_here[_ORIGIN] = 1.0
            of_shift_here[_DRIFT_RATE] = instant
            of_load_here = side * of_load[0]
            of_load_here[_MIDDLE] = 1.0
            shift_here = side * shift[0] + values[_ORIGIN] + values[_DRIFT_RATE] * instant
            load_here = side * load[0] + values[_MIDDLE]
            model = shift_here / range_of_shift + load_here / range_of_load
            error = max(turn.error, _ERROR_OF_TURN)
            residuals[k] = (model - turn.load) / error
            derivatives[k] = of_shift_here / range_of_shift + of_load_here / range_of_load
            derivatives[k] /= error
        return residuals, derivatives

    def sum_of_squares(self, values: Array) -> float:
        """Of the residuals."""
        distances = self.residuals(values)[0]
        return float(distances @ distances)

    def least(self, start: Array, fixed: frozenset[int], *, gross: bool) -> tuple[float, Array]:
        """Least sum of squares, and the parameters (7,) that give it; `gross` ties f to R."""
        from scipy.optimize import least_squares

        held = set(fixed)
        if self.rows.compliance is not None:
            held.add(_COMPLIANCE)
        if gross:
            held.add(_RANGE)
        else:
            held.add(_SLIDE)
        free = np.array([k for k in range(7) if k not in held])
        sizes = self.sizes

        def placed(steps: Array) -> Array:
            values = start.copy()
            values[free] += steps * sizes[free]
            values[_LOG_F] = min(max(values[_LOG_F], -30.0), 30.0)
            if gross:
                values[_RANGE] = math.exp(values[_LOG_F]) / self.curve.sliding
            return values

        latest: dict[bytes, tuple[Array, Array]] = {}

        def both(steps: Array) -> tuple[Array, Array]:
            key = steps.tobytes()
            if key not in latest:
                values = placed(steps)
                residuals, derivatives = self.residuals(values)
                if gross:  # R goes with ln f
                    derivatives[:, _LOG_F] += values[_RANGE] * derivatives[:, _RANGE]
                latest.clear()
                latest[key] = (residuals, derivatives[:, free] * sizes[free])
            return latest[key]

        answer = least_squares(
            lambda steps: both(steps)[0],
            np.zeros(len(free)),
            jac=lambda steps: both(steps)[1],
            method="lm",
            xtol=1e-8,
            ftol=1e-10,
            max_nfev=60,
        )
        return 2 * float(answer.cost), placed(answer.x)

    def start(self, log_friction: float, slide: float) -> Array:
        """Parameters from which a fit begins: the rig takes up what U moves more than theory."""
        rows = self.rows
        extent = self.rows.sizes[_MIDDLE]
        highest, lowest = np.quantile(rows.load, [0.98, 0.02])
        extent = float(highest - lowest)
        if slide > 0:
            log_friction = math.log(self.curve.sliding * extent)
        friction = math.exp(log_friction)
        range_of_shift = float(np.ptp(np.quantile(rows.shift, [0.01, 0.99])))
        moved = 2 * friction * float(self.curve.value(np.array(extent / 2 / friction)))
        compliance = rows.compliance
        if compliance is None:
            compliance = ((1 - slide) * range_of_shift - moved) / extent
        middle_of_shift = float(np.mean(np.quantile(rows.shift, [0.02, 0.98])))
        return np.array(
            [
                log_friction,
                (highest + lowest) / 2,
                extent,
                compliance,
                middle_of_shift,
                0.0,
                slide * range_of_shift,
            ]
        )

    def best(self) -> tuple[_Least, _Least]:
        """The best partial and the best gross loop."""
        highest, lowest = np.quantile(self.rows.load, [0.98, 0.02])
        least = math.log(self.curve.sliding * float(highest - lowest))
        logs = least + np.linspace(math.sqrt(_ABOVE), math.sqrt(math.log(_WIDEST)), _TRIALS) ** 2
        partial = [self.start(log_friction, 0.0) for log_friction in logs.tolist()]
        gross = [self.start(0.0, slide) for slide in _SLIDES]
        best = []
        for starts, is_gross in ((partial, False), (gross, True)):
            sums = np.array([self.sum_of_squares(start) for start in starts])
            walled = np.concatenate([[math.inf], sums, [math.inf]])
            minima = np.flatnonzero((sums <= walled[:-2]) & (sums <= walled[2:]))
            lowest_first = minima[np.argsort(sums[minima])][:_MINIMA]
            fits = [
                self._within(*self.least(starts[k], frozenset(), gross=is_gross), gross=is_gross)
                for k in lowest_first.tolist()
            ]
            best.append(min(fits, key=lambda fit: fit.squares))
        return best[0], best[1]

    def again(self, partial: _Least, gross: _Least) -> tuple[_Least, _Least]:
        """The best partial and the best gross loop from parameters near them."""
        return (
            self._within(*self.least(partial.values, frozenset(), gross=False), gross=False),
            self._within(*self.least(gross.values, frozenset(), gross=True), gross=True),
        )

    def _within(self, squares: float, values: Array, *, gross: bool) -> _Least:
        """A fit, at the wall between partial and gross loops where it lies beyond."""
        if not gross and self._beyond_sliding(values):
            values = values.copy()
            values[_LOG_F] = math.log(self.curve.sliding * values[_RANGE])
            squares, values = self.least(values, frozenset([_SLIDE]), gross=True)
        if gross and values[_SLIDE] < 0:
            values = values.copy()
            values[_SLIDE] = 0.0
            squares, values = self.least(values, frozenset([_SLIDE]), gross=True)
        return _Least(squares, values)

    def _beyond_sliding(self, values: Array) -> bool:
        return bool(values[_LOG_F] < math.log(self.curve.sliding * values[_RANGE]))

    def at_friction(self, log_friction: float, start: Array, *, gross: bool) -> _Least:
        """The best loop of one kind at this f."""
        held = frozenset([_LOG_F])
        values = start.copy()
        values[_LOG_F] = log_friction
        if not gross:
            squares, values = self.least(values, held, gross=False)
            return _Least(math.inf if self._beyond_sliding(values) else squares, values)
        squares, values = self.least(values, held, gross=True)
        if values[_SLIDE] < 0:
            values = values.copy()
            values[_SLIDE] = 0.0
            squares, values = self.least(values, held | {_SLIDE}, gross=True)
        return _Least(squares, values)

    def interval_end(
        self, fits: tuple[_Least, _Least], side: float, excess: float, step: float
    ) -> float | None:
        """ln f on this side (1 or -1) of the better fit at which the least sum of squares exceeds
        its own by `excess`; None where it does not. `fits` are the best partial and the best gross
        loop.
        """
        least, best = min(fits, key=lambda fit: fit.squares)
        latest = {gross: fit.values for gross, fit in zip((False, True), fits, strict=True)}
        first = fits[1].squares < fits[0].squares

        def root_of_excess(log_trial: float) -> float:
            """1 where the sum of squares passes the limit; nearly linear in ln f."""
            nonlocal first
            squares = math.inf
            for gross in (first, not first):
                fit = self.at_friction(log_trial, latest[gross], gross=gross)
                if math.isfinite(fit.squares):
                    latest[gross] = fit.values
                if fit.squares < squares:
                    squares = fit.squares
                    first = gross
                if squares <= least + excess:  # whatever the other kind gives
                    break
            return math.sqrt(max(squares - least, 0.0) / excess)

        return passes(root_of_excess, float(best[_LOG_F]), side, step)


def passes(value: Callable[[float], float], begin: float, side: float, step: float) -> float | None:
    """Where a value that grows from 0 at `begin` on one side (1 or -1) passes 1, to 1 % of its
    distance from `begin`; None where it does not up to a factor of 60 in e to its argument.

    >>> end = passes(lambda x: 2 * abs(x), 0.0, 1.0, 0.3)
    >>> abs(end - 0.5) < 0.005
    True
    """
    inner, at_inner = 0.0, 0.0
    for _ in range(_STEPS):
        outer = inner + min(step, 0.5)
        at_outer = value(begin + side * outer)
        if at_outer > 1:
            break
        if outer > math.log(_FARTHEST):
            return None
        step = 1.3 * outer * (1 / max(at_outer, 0.1)) - outer
        inner, at_inner = outer, at_outer
    else:
        return None
    for _ in range(_NARROWED):
        if outer - inner < 0.01 * outer:
            break
        share = (1 - at_inner) / (min(at_outer, 1e6) - at_inner)
        middle = inner + float(np.clip(share, 0.1, 0.9)) * (outer - inner)
        at_middle = value(begin + side * middle)
        if abs(at_middle - 1) < 0.01:
            return begin + side * middle
        if at_middle > 1:
            outer, at_outer = middle, at_middle
        else:
            inner, at_inner = middle, at_middle
    return begin + side * outer


def _noise_of_rows(
    found: Distances, weights: Weights, smallest: Weights, freedom: int, ratio: tuple[float, float]
) -> Weights:
    """Sigma of U and of Q that are most likely for these distances; `ratio` is ln(sigma of U/sigma
    of Q) that neighbouring rows show, and its scatter.
    """
    expected = ratio[0] - math.log(weights.shift / weights.load)
    from scipy.optimize import minimize

    squares = found.value**2 * len(found.value) / freedom
    parts = found.across**2

    def unlikely(logs: Array) -> float:
        variance = parts @ np.exp(2 * logs)
        prior = float((logs[0] - logs[1] - expected) ** 2) / ratio[1] ** 2
        return float(np.sum(squares / variance + np.log(variance))) + prior

    common = math.log(max(math.sqrt(float(np.mean(squares))), 1e-12))
    answer = minimize(unlikely, np.full(2, common), method="Nelder-Mead", options={"xatol": 1e-3})
    factors = np.exp(answer.x)
    return Weights(
        max(float(factors[0]) * weights.shift, smallest.shift),
        max(float(factors[1]) * weights.load, smallest.load),
    )


def _better(fits: tuple[_Least, _Least]) -> _Least:
    return min(fits, key=lambda fit: fit.squares)


@dataclass(frozen=True, eq=False)
class BestLoop:
    """The loop that follows rows best, before its interval is sought.

    Attributes
    ----------
    values
        (7,) its parameters
    gross
        whether the contact slides as a whole at its ends
    distances, misfit
        of the rows, and what they show
    """

    search: _Search
    fits: tuple[_Least, _Least]
    values: Array
    gross: bool
    distances: Distances
    misfit: Misfit
    freedom: int

    @property
    def first_differs(self) -> bool:
        """Whether the rows of the first or the second half cycle lie on another loop: inside the
        fitted one, or outside, on the mean.
        """
        phase = self.search.rows.branches.phase
        outwards = np.where(self.distances.place < 1, -1.0, 1.0) * self.distances.value
        apart = outwards - np.mean(outwards)
        half_cycle = np.floor(2 * (np.maximum.accumulate(phase) - phase[0]))
        for k in (0, 1):
            rows = half_cycle == k
            count = int(np.count_nonzero(rows))
            if count < 2 or count == len(rows):
                continue
            scatter = float(np.std(apart[~rows])) / math.sqrt(count)
            if abs(float(np.mean(apart[rows]))) > _RUN_IN_SEEN * scatter:
                return True
        return False


def _misfit(found: Distances, weights: Weights, smallest: Weights) -> Misfit:
    """By neighbours in time, and by neighbours on the loop, which are of several cycles."""
    order = np.argsort(found.place, kind="stable")
    inwards = np.where(found.place > 1, -1.0, 1.0) * found.value
    in_time = misfit_of(found.value, weights.shift)
    on_loop = misfit_of(inwards[order], weights.shift)
    misfit = max(in_time, on_loop, key=lambda misfit: misfit.correlation)
    if weights == smallest and float(np.mean(found.value**2)) < _BY_DIGITS:
        # Rows that are rounded alike lie on one side: no fault of the model, but fewer rows' worth.
        return replace(misfit, systematic=0.0)
    return misfit


def best_loop(rows: MeasuredRows, curve: MemoryCurve) -> BestLoop:
    """The parameters that fit the rows best, with the noise that the rows show."""
    smallest = Weights(
        *(
            max(step / math.sqrt(12), _LEAST_NOISE * float(np.max(np.abs(values))))
            for step, values in zip(rows.resolution, (rows.shift, rows.load), strict=True)
        )
    )
    weights = Weights(
        max(row_noise(rows.shift), smallest.shift), max(row_noise(rows.load), smallest.load)
    )
    search = _Search(rows, curve, weights)
    freedom = len(rows.shift) - 6 - (rows.compliance is None)
    fits = search.best()
    ratio = (math.log(weights.shift / weights.load), _RATIO_OF_NOISE)
    for k in range(_REWEIGHTED):
        found = distances_from(rows, curve, _better(fits).values, search.weights)
        if k == 0:
            # Where the first fit leaves what neighbouring rows show, they show noise alone.
            misjudged = abs(math.log(max(float(np.std(found.value)), 1e-9)))
            by_chance = _OF_ROW_NOISE / math.sqrt(len(rows.shift))
            ratio = (ratio[0], min(max(misjudged, by_chance), _RATIO_OF_NOISE))
        weights = _noise_of_rows(found, search.weights, smallest, freedom, ratio)
        changes = np.array(weights) / np.array(search.weights) - 1
        if np.max(np.abs(changes)) < _SAME_NOISE:
            break
        search = replace(search, weights=weights)
        # With another noise another minimum may be the lowest.
        fits = search.best() if k == 0 else search.again(*fits)
    values = _better(fits).values
    found = distances_from(rows, curve, values, search.weights)
    return BestLoop(
        search=search,
        fits=fits,
        values=values,
        gross=fits[1].squares < fits[0].squares,
        distances=found,
        misfit=_misfit(found, search.weights, smallest),
        freedom=freedom,
    )


def with_interval(best: BestLoop, error_of_theory: float) -> MasingFit:
    """The best loop with the interval of f.

    Parameters
    ----------
    error_of_theory
        of a fitted f, of itself, by the samples of the curve
    """
    from scipy.stats import f as fisher

    search = best.search
    variance = max(_better(best.fits).squares / best.freedom, 1.0)
    errors = _standard_errors(search, best.values, best.gross, variance)
    widening = best.misfit.widening
    excess = float(fisher.ppf(0.95, 1, best.freedom)) * widening**2 * variance
    step = float(np.clip(2 * errors[_LOG_F] * widening, 1e-9, 0.3))
    friction = math.exp(best.values[_LOG_F])
    down = search.interval_end(best.fits, -1.0, excess, step)
    up = search.interval_end(best.fits, 1.0, excess, step)
    own = friction * error_of_theory
    if best.gross:
        own = math.hypot(own, _digits_of_plateau(search.rows, search.curve, search.weights))
    low = 0.0 if down is None else friction - math.hypot(friction - math.exp(down), own)
    high = None if up is None else friction + math.hypot(math.exp(up) - friction, own)
    return MasingFit(
        friction=friction,
        low=max(low, 0.0),
        high=high,
        values=best.values,
        errors=errors,
        gross=best.gross,
        weights=search.weights,
        distances=best.distances,
        misfit=best.misfit,
    )


def _digits_of_plateau(rows: MeasuredRows, curve: MemoryCurve, weights: Weights) -> float:
    """Of f, by the last digit of Q: the rows of a plateau all have the same one if no noise moves
    them.
    """
    step = rows.resolution[1]
    if weights.load**2 - step**2 / 12 > (_MOVES_DIGITS * step) ** 2:
        return 0.0
    # f = R/2P, and R is the difference of two plateaus that are rounded alike.
    return 2 * _OF_STEP * step * curve.sliding


def _standard_errors(search: _Search, values: Array, gross: bool, variance: float) -> Array:
    """Of the parameters (7,), by the curvature of the sum of squares."""
    derivatives = search.residuals(values)[1]
    if gross:
        derivatives[:, _LOG_F] += values[_RANGE] * derivatives[:, _RANGE]
    held = {_RANGE} if gross else {_SLIDE}
    if search.rows.compliance is not None:
        held.add(_COMPLIANCE)
    free = np.array([k for k in range(7) if k not in held])
    scaled = derivatives[:, free] * search.sizes[free]
    errors = np.zeros(7)
    inverse = np.linalg.pinv(scaled.T @ scaled)
    errors[free] = np.sqrt(np.maximum(np.diag(inverse), 0.0) * variance) * search.sizes[free]
    return errors
