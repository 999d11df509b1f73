"""Rows of a loop of Q over U at constant P: turning points of Q, the branch each row lies on, f by
the memory curve of a branch.

# notation: A = 2/E*, C compliance of the rig, f friction coefficient, Q_max and Q_min turning
#           points of Q, R = Q_max - Q_min, u(h) U of the initial loading by Q = h, sigma standard
#           deviation of the noise of a row

At constant P nothing depends on the form of Q or of U over time. By Masing's rule a branch hangs on
its turning point:

    rising:   U = -u(R/2) + 2 u((Q - Q_min)/2)
    falling:  U = u(R/2) - 2 u((Q_max - Q)/2),   u(h; f) = f v(h/f)

A row is placed by its Q and its branch. f, the turning points, C and the origin of U are found by
least squares of

    (U - C Q - U0 - u_branch(Q)) / sqrt(sigma_U^2 + (dU/dQ)^2 sigma_Q^2),

the distance of a row from its branch where U and Q both have noise. The turning points lie between
rows: they are parameters of the fit, beside what the rows of Q near them say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from scenes import InputError, Scene

Array = NDArray[np.float64]

# Levels of Q, as shares of its range, that rows must pass between two turning points: noise turns Q
# more often.
_LOWER, _UPPER = 0.25, 0.75
# Scatter of Q from row to row beyond this share of its amplitude hides the loop; rows of a cycle
# below which turning points can't be told.
_SCATTER, _FEWEST_OF_CYCLE = 0.15, 8
# Rows on each side of a turning point that two parabolas are fitted to: the fewest that leave a
# residual, and how they grow.
_WINDOW, _GROWTH = 3, 1.5
# Places of the joint of the two parabolas that are tried.
_JOINTS = 25
# Residuals of the parabolas over the noise of Q, beyond which the window is too long for parabolas.
_AS_NOISE = 1.15
# Variance of two joined parabolas at their joint, times the rows on each side over the variance of
# a row.
_AT_JOINT = 4.5
# Samples of the memory curve, closer towards gross sliding, where its slope grows as a logarithm,
# and how near they come to it.
_SAMPLES, _BEFORE_SLIDING = 1001, 1e-6
# First trials of f, from gross sliding to so many times as much; beyond, a loop is a line.
_TRIALS, _WIDEST = 24, 40.0
# ln f on the way of a fit: so far below sliding the curve goes on straight, lest a fit end at a
# wall; and a start above it.
_BELOW, _ABOVE = 0.2, 0.04
# Chance gives so much of the sum of squares over its mean in 95 %: chi squared of one degree.
_CHI = 3.841
# Fits with the noise of the fit before: it changes by less than a part in ten then.
_REWEIGHTED = 8
# Distance from a branch, in sigma and over that from the other one, from which a row beside a
# turning point is the other's.
_FAR = 4.0
# Steps outwards to the end of an interval, each 1.3 times the one before, and halvings: to 1 % of
# the last step.
_STEPS, _HALVED = 60, 6
# Noise of rows that show none, over their largest value: f is not known better than theory's
# samples leave it.
_LEAST_NOISE = 1e-9
# Theory's own error of a fitted f: samples of the memory curve, of itself.
_OF_THEORY = 1e-6


class TurningPoint(NamedTuple):
    """Q at a turning point, and its standard error."""

    load: float
    error: float


@dataclass(frozen=True, eq=False)
class Branches:
    """Where rows lie on a loop.

    Attributes
    ----------
    phase : (n,) cycles since a lowest Q, by the share of the branch that Q has passed; grows with
    the rows but for noise rising : (n,) whether Q grows along the row's branch
    highest, lowest : turning points
    load_noise : sigma of Q, as far as neighbouring rows show it
    """

    phase: Array
    rising: NDArray[np.bool_]
    highest: TurningPoint
    lowest: TurningPoint
    load_noise: float

    @property
    def cycles(self) -> float:
        """How many the rows cover."""
        return float(self.phase[-1] - self.phase[0])


@dataclass(frozen=True, eq=False)
class BranchFit:
    """f at which the memory curve follows the rows best, and what was fitted with it.

    Attributes
    ----------
    friction, low, high : f and its 95 % interval; high None where no larger f can be told from it
    highest, lowest : turning points of Q [force per thickness]
    compliance, origin : C [1/stress] and U0 [length]
    shift_noise, load_noise : sigma of U and of Q
    """

    friction: float
    low: float
    high: float | None
    highest: float
    lowest: float
    compliance: float
    origin: float
    shift_noise: float
    load_noise: float


# ----------------------------------------------------------------------------- branches of the rows
def row_noise(values: Array) -> float:
    """Standard deviation of white noise of rows (n,), from the median of their fourth differences,
    of variance 70 sigma^2.

    Of rows without noise it is what a smooth curve leaves in them, which is small.
    """
    return 1.4826 * float(np.median(np.abs(np.diff(values, 4)))) / math.sqrt(70)


def find_branches(
    shift: Array, load: Array, time: Array, resolution: float, source: str
) -> Branches:
    """Turning points and branches of rows of Q.

    Parameters
    ----------
    shift, load, time : U, Q and time of the rows, (n,) each; time ascends
    resolution : step of Q that the digits of the rows resolve

    Raises
    ------
    InputError
        Where Q does not go up and down, or where the rows cover less than a cycle.
    """
    noise = max(row_noise(load), resolution / math.sqrt(12))
    bottom, top = _range(load, noise)
    if noise > _SCATTER * (top - bottom) / 2:
        raise InputError(
            f"{source}: its Q goes up and down to {200 * noise / np.ptp(load):.0f} % of its"
            f" amplitude only (limit {100 * _SCATTER:.0f} %), the rest is scatter: give the rows in"
            " the order of time, and whole cycles"
        )
    begins, ends, upward = _crossings(load, bottom, top)
    cyclic_load = load
    cyclic_time = time
    period = math.inf
    copies = 1
    if len(begins) < 3:  # less than two cycles: the first one follows itself round
        end = _closing_row(shift, load, begins, upward, noise)
        if end is None:
            covered = float(
                np.sum(np.abs(np.diff(_turned(load, begins, ends)))) / (2 * (top - bottom))
            )
            raise InputError(
                f"{source}: its rows cover {covered:.2g} of a cycle: a loop needs a whole one"
            )
        closed = abs(load[end] - load[0]) < 0.5 * float(np.median(np.abs(np.diff(load))))
        step = 0.0 if closed else float(np.median(np.diff(time)))
        period = float(time[end]) - float(time[0]) + step
        begin = 1 if closed else 0
        cyclic_load = np.concatenate([load[: end + 1], load[begin : end + 1]])
        cyclic_time = np.concatenate([time[: end + 1], time[begin : end + 1] + period])
        copies = 2
        begins, ends, upward = _crossings(cyclic_load, bottom, top)
    middles = _middles(cyclic_load, cyclic_time, begins, ends, (bottom + top) / 2)
    if len(middles) < 3 or 2 * (ends[-1] - begins[0]) / (len(begins) - 1) < _FEWEST_OF_CYCLE:
        raise InputError(
            f"{source}: a loop needs at least {_FEWEST_OF_CYCLE} rows a cycle, in the order of time"
        )
    centres = (middles[1:] + middles[:-1]) / 2  # of the two crossings of a turning point
    is_top = upward[:-1]
    found = {
        side: _turning_point(
            cyclic_load,
            cyclic_time,
            centres[is_top == side],
            np.diff(middles)[is_top == side],
            side,
            noise,
            copies,
        )
        for side in (True, False)
    }
    (highest, above), (lowest, below) = found[True], found[False]

    # Turning points in the order of time, with one before the first and one behind the last.
    half = {side: float(np.median(np.diff(middles)[is_top == side])) / 2 for side in (True, False)}
    place = {True: above, False: below}
    turns = centres + np.where(is_top, above, below)
    turns = np.concatenate(
        [
            [middles[0] - half[not upward[0]] + place[not upward[0]]],
            turns,
            [middles[-1] + half[bool(upward[-1])] + place[bool(upward[-1])]],
        ]
    )
    first_is_top = not bool(upward[0])
    # the record begins again: the turning points of the second time round belong to the first too
    if math.isfinite(period):
        first_is_top = not first_is_top
        turns = np.concatenate([turns[1:3] + period * lap for lap in range(-2, 3)])
    branch = np.asarray(np.searchsorted(turns, time, side="right") - 1)
    begins_at_top = (branch % 2 == 0) == first_is_top
    rising = ~begins_at_top
    start = np.where(begins_at_top, highest.load, lowest.load)
    passed = np.clip(np.abs(load - start) / (highest.load - lowest.load), 0.0, 1.0)
    return Branches(
        (branch + passed + (1 if first_is_top else 0)) / 2, rising, highest, lowest, noise
    )


def _range(load: Array, noise: float) -> tuple[float, float]:
    """Lowest and highest Q; what noise adds to them does not matter for levels within."""
    if not np.ptp(load) > 8 * noise:
        return float(load.min()), float(load.max())
    return float(load.min()) + 2 * noise, float(load.max()) - 2 * noise


def _crossings(
    load: Array, bottom: float, top: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
    """Crossings of the levels: last row before and first row behind each, and whether Q rises
    there.
    """
    low = load < bottom + _LOWER * (top - bottom)
    high = load > bottom + _UPPER * (top - bottom)
    rows = np.flatnonzero(low | high)
    state = high[rows]
    changes = np.flatnonzero(state[1:] != state[:-1])
    return rows[changes], rows[changes + 1], state[changes + 1]


def _turned(load: Array, begins: NDArray[np.intp], ends: NDArray[np.intp]) -> Array:
    """First Q, the extreme of each stretch between crossings, last Q."""
    edges = [0, *((begins + ends) // 2 + 1).tolist(), len(load)]
    middle = float(load.max() + load.min()) / 2
    stretches = [load[first:last] for first, last in pairwise(edges) if last > first]
    extremes = [float(part[np.argmax(np.abs(part - middle))]) for part in stretches]
    return np.array([load[0], *extremes, load[-1]])


def _closing_row(
    shift: Array, load: Array, begins: NDArray[np.intp], upward: NDArray[np.bool_], noise: float
) -> int | None:
    """The row nearest to the first one, a cycle later on the same branch; None where the rows do
    not come back there.
    """
    if not len(begins):
        return None
    stretches = np.split(np.arange(len(load)), begins + 1)  # rows of high Q and of low Q by turns
    first_high = not bool(upward[0])
    first = load[stretches[0]]
    goes_on = (
        np.max(first) > load[0] + 4 * noise if first_high else np.min(first) < load[0] - 4 * noise
    )
    rising = bool(goes_on) == first_high
    # The branch of the first row begins again at the first lowest Q behind a highest one, or the
    # other way round.
    place = 1 if rising == first_high else 2
    if len(stretches) <= place:
        return None
    rows = stretches[place]
    turn = int(rows[np.argmin(load[rows]) if rising else np.argmax(load[rows])])
    apart = [values[turn:] - values[0] for values in (load, shift)]
    steps = [float(np.max(np.abs(np.diff(values)))) for values in (load, shift)]
    # Along the branch U changes with Q, roughly as over the whole loop; across the loop it changes
    # alone.
    across = apart[1] - np.ptp(shift) / np.ptp(load) * apart[0]
    near = (np.abs(apart[0]) <= 2 * steps[0] + 4 * noise) & (
        np.abs(across) <= steps[1] + 5 * row_noise(shift)
    )
    if not np.any(near):
        return None
    distance = np.hypot(apart[0] / np.ptp(load), apart[1] / np.ptp(shift))
    return turn + int(np.argmin(np.where(near, distance, math.inf)))


def _middles(
    load: Array, time: Array, begins: NDArray[np.intp], ends: NDArray[np.intp], middle: float
) -> Array:
    """Time at which Q passes its middle at each crossing, by a straight line through the rows
    between the levels.
    """
    times = []
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        rows = slice(begin, end + 1)
        centre = float(np.mean(time[rows]))
        rate, level = np.polyfit(time[rows] - centre, load[rows], 1)
        at = centre + (middle - level) / rate if rate else centre
        times.append(min(max(float(at), float(time[begin])), float(time[end])))
    return np.array(times)


def _turning_point(
    load: Array, time: Array, centres: Array, lengths: Array, is_top: bool, noise: float, alike: int
) -> tuple[TurningPoint, float]:
    """Q at the turning points of a side, all laid over each other, and their place behind the
    middle of their crossings.

    Two parabolas that meet at the turning point describe a wave that is round there as well as one
    with a corner. The window is as long as they describe the rows to within the noise.
    """
    sign = 1.0 if is_top else -1.0
    count = len(centres)
    half = float(np.median(lengths)) / 2
    row = np.searchsorted(time, np.concatenate([centres - half, centres + half]))
    in_half = float(np.mean(row[count:] - row[:count])) / 2
    behind = np.searchsorted(centres, time)  # the nearest centre of each row
    nearest = np.clip(behind, 1, max(count - 1, 1)) if count > 1 else np.zeros(len(time), dtype=int)
    if count > 1:
        nearest = np.where(
            time - centres[nearest - 1] < centres[nearest] - time, nearest - 1, nearest
        )
    apart = (time - centres[nearest]) / half  # -1 and 1 at the crossings
    values = sign * load
    # Where the turning point is: the middle of the rows that are nearly as high as any.
    inside = np.abs(apart) < 1
    high = inside & (values >= np.max(values[inside]) - 0.05 * np.ptp(values) - 2 * noise)
    middle = float(np.median(apart[high]))
    window = float(_WINDOW)
    fits: list[tuple[float, float, float]] = []
    while window < max(in_half, _WINDOW + 0.5):
        reach = (window + 0.5) / in_half
        rows = np.abs(apart - middle) <= reach
        x, y = (apart[rows] - middle) / reach, values[rows]
        fit = _two_parabolas(x, y)
        if fit is not None:
            height, where, residual = fit
            if fits and residual > _AS_NOISE * noise:
                break
            fits.append((height, middle + where * reach, window))
        window *= _GROWTH
    if not fits:
        height, where, window = float(np.max(values[inside])), middle, 1.0
        return TurningPoint(sign * height, float(noise + np.ptp(values) / in_half)), where * half
    height, where, window = fits[-1]
    shorter = fits[-2][0] if len(fits) > 1 else float(np.max(values[inside]))
    error = math.hypot(
        noise * math.sqrt(_AT_JOINT / (window * max(count // alike, 1))), height - shorter
    )
    return TurningPoint(sign * height, error), where * half


def _two_parabolas(x: Array, y: Array) -> tuple[float, float, float] | None:
    """Highest value of two parabolas that meet, fitted to rows (n,), its place, and the root mean
    square of the residuals.
    """
    freedom = len(x) - 6
    if freedom < 1:
        return None
    best = (math.inf, 0.0, np.zeros(5))
    for joint in np.linspace(-0.5, 0.5, _JOINTS):
        left = np.minimum(x - joint, 0.0)
        right = np.maximum(x - joint, 0.0)
        columns = np.column_stack([np.ones_like(x), left, left**2, right, right**2])
        terms = np.linalg.lstsq(columns, y, rcond=None)[0]
        rest = y - columns @ terms
        squares = float(rest @ rest)
        if squares < best[0]:
            best = (squares, float(joint), terms)
    squares, joint, terms = best
    fine = np.linspace(-0.7, 0.7, 281)
    left = np.minimum(fine - joint, 0.0)
    right = np.maximum(fine - joint, 0.0)
    curve = terms[0] + terms[1] * left + terms[2] * left**2 + terms[3] * right + terms[4] * right**2
    place = int(np.argmax(curve))
    return float(curve[place]), float(fine[place]), math.sqrt(squares / freedom)


# --------------------------------------------------------------------------------- the memory curve
@dataclass(frozen=True, eq=False)
class MemoryCurve:
    """u(h; f) = f v(h/f) at the scene's constant P: half-plane theory at samples, cubic between
    them.

    Below 0 and beyond gross sliding v goes on straight: noise takes rows there.
    """

    limit: float  # h/f of the last sample
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


def memory_curve(scene: Scene) -> MemoryCurve:
    """The curve from the falling branch of a loop that nearly slides: u(h) is half of U(Q_max) -
    U(Q_max - 2 h).
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
    return MemoryCurve(limit, spline, spline.derivative())


# ------------------------------------------------------------------------------------------ the fit
@dataclass(frozen=True, eq=False)
class _Rows:
    """What a fit rests on: rows of U and Q, their branch, sigma of both and turning points."""

    shift: Array
    load: Array
    branches: Branches
    curve: MemoryCurve
    compliance: float | None  # given, else it is fitted
    least: float  # f of gross sliding
    shift_noise: float
    load_noise: float

    def loop(self, friction: float, highest: float, lowest: float) -> tuple[Array, Array]:
        """U of theory at the rows, without rig and origin, and dU/dQ."""
        rising = self.branches.rising
        passed = np.where(rising, self.load - lowest, highest - self.load) / 2
        half = (highest - lowest) / 2
        # Beyond its other turning point a branch goes on straight.
        inside = np.minimum(passed, half) / friction
        rate = self.curve.rate(inside)
        apart = 2 * friction * self.curve.value(inside) + 2 * rate * np.maximum(passed - half, 0.0)
        edge = friction * float(self.curve.value(np.array(half / friction)))
        return np.where(rising, apart - edge, edge - apart), rate

    def linear(self, friction: float, highest: float, lowest: float) -> tuple[float, float]:
        """C and U0 by linear least squares in U alone: where a fit begins."""
        shift, _ = self.loop(friction, highest, lowest)
        rest = self.shift - shift
        if self.compliance is not None:
            return self.compliance, float(np.mean(rest - self.compliance * self.load))
        columns = np.column_stack([self.load, np.ones_like(rest)])
        slope, origin = np.linalg.lstsq(columns, rest, rcond=None)[0]
        return float(slope), float(origin)

    def distances(self, friction: float, terms: Array) -> Array:
        """Of the rows from the branches, and of the turning points from those of Q alone, each over
        its sigma: (n + 2,).
        """
        highest, lowest, compliance, origin = terms.tolist()
        shift, rate = self.loop(friction, highest, lowest)
        across = np.hypot(self.shift_noise, (compliance + rate) * self.load_noise)
        rows = (self.shift - compliance * self.load - origin - shift) / across
        top, bottom = self.branches.highest, self.branches.lowest
        turns = [(highest - top.load) / top.error, (lowest - bottom.load) / bottom.error]
        return np.concatenate([rows, turns])

    def best_terms(self, friction: float, start: Array) -> tuple[float, Array]:
        """Least sum of squares at this f, and Q_max, Q_min, C, U0 that give it, from a start near
        them.
        """
        total, _, terms = self._least(friction, start, friction_fitted=False)
        return total, terms

    def best(self, friction: float, start: Array) -> tuple[float, float, Array]:
        """Least sum of squares, and f and the four terms that give it, from a start near them."""
        return self._least(friction, start, friction_fitted=True)

    def _least(
        self, friction: float, start: Array, *, friction_fitted: bool
    ) -> tuple[float, float, Array]:
        from scipy.optimize import least_squares

        free = np.array([friction_fitted, True, True, self.compliance is None, True])
        sizes = np.array([1.0, *self.sizes()])
        middle = np.array([math.log(friction), *start])

        def placed(values: Array) -> Array:
            at = middle.copy()
            at[free] += values * sizes[free]
            at[0] = min(max(at[0], math.log(self.least) - _BELOW), math.log(self.least * _WIDEST))
            return at

        def of_free(values: Array) -> Array:
            at = placed(values)
            return self.distances(math.exp(at[0]), at[1:])

        answer = least_squares(
            of_free, np.zeros(np.count_nonzero(free)), method="lm", xtol=1e-11, ftol=1e-11
        )
        at = placed(answer.x)
        return 2 * float(answer.cost), math.exp(at[0]), at[1:]

    def with_rows_at_turns_moved(self, friction: float, terms: Array) -> _Rows:
        """The rows beside a turning point on their other branch where that is far nearer: its place
        is known to a row alone.
        """
        rising = self.branches.rising
        changes = np.flatnonzero(rising[1:] != rising[:-1])
        beside = np.unique(np.concatenate([changes, changes + 1]))
        turned = rising.copy()
        turned[beside] = ~rising[beside]
        other = replace(self, branches=replace(self.branches, rising=turned))
        here = np.abs(self.distances(friction, terms)[:-2])
        there = np.abs(other.distances(friction, terms)[:-2])
        moved = (rising != turned) & (here > _FAR * np.maximum(there, 1.0))
        return replace(
            self, branches=replace(self.branches, rising=np.where(moved, turned, rising))
        )

    def sizes(self) -> Array:
        """Of Q_max, Q_min, C and U0."""
        loads, shifts = float(np.ptp(self.load)), float(np.ptp(self.shift))
        return np.array([loads, loads, shifts / loads, shifts])


def fit_branches(
    shift: Array,
    load: Array,
    branches: Branches,
    scene: Scene,
    least: float,
    compliance: float | None,
    resolution: tuple[float, float],
) -> BranchFit:
    """f, turning points and rig that fit the rows best, with the interval of f.

    Parameters
    ----------
    shift, load : U and Q of the rows, (n,) each
    least : f of gross sliding, below which there is no loop
    compliance : C of the rig; None to fit it
    resolution : steps of U and Q that the digits of the rows resolve
    """
    curve = memory_curve(scene)
    smallest = [
        max(step / math.sqrt(12), _LEAST_NOISE * float(np.max(np.abs(values))))
        for step, values in zip(resolution, (shift, load), strict=True)
    ]
    rows = _Rows(
        shift,
        load,
        branches,
        curve,
        compliance,
        least,
        max(row_noise(shift), smallest[0]),
        max(branches.load_noise, smallest[1]),
    )
    top, bottom = branches.highest.load, branches.lowest.load

    def begin(friction: float) -> Array:
        return np.array([top, bottom, *rows.linear(friction, top, bottom)])

    trials = least * np.exp(np.linspace(_ABOVE, math.log(_WIDEST), _TRIALS))
    sums = [float(np.sum(rows.distances(trial, begin(trial)) ** 2)) for trial in trials.tolist()]
    best = int(np.argmin(sums))
    friction, terms = float(trials[best]), begin(float(trials[best]))
    freedom = len(shift) - 4 - (compliance is None)
    for _ in range(_REWEIGHTED):
        lowest, friction, terms = rows.best(friction, terms)
        rows = rows.with_rows_at_turns_moved(friction, terms)
        ratio = math.sqrt(float(np.sum(rows.distances(friction, terms)[:-2] ** 2)) / freedom)
        noises = (
            max(ratio * rows.shift_noise, smallest[0]),
            max(ratio * rows.load_noise, smallest[1]),
        )
        settled = (
            abs(noises[0] / rows.shift_noise - 1) < 0.05
            and abs(noises[1] / rows.load_noise - 1) < 0.05
        )
        rows = replace(rows, shift_noise=noises[0], load_noise=noises[1])
        if settled:
            break
    lowest, friction, terms = rows.best(friction, terms)
    friction = max(friction, least * (1 + 1e-9))
    low, high = math.log(least * (1 + 1e-9)), math.log(least * _WIDEST)
    spread = max(lowest / freedom, 1.0)

    def edge(end: float) -> float | None:
        """ln f where the sum of squares passes its limit on the way to `end`; None where it does
        not.
        """
        return _passes(rows, math.log(friction), terms, end, lowest + _CHI * spread)

    down, up = edge(low), edge(high)
    own = friction * _OF_THEORY
    return BranchFit(
        friction=friction,
        low=max(least, (math.exp(down) if down is not None else least) - own),
        high=None if up is None else math.exp(up) + own,
        highest=float(terms[0]),
        lowest=float(terms[1]),
        compliance=float(terms[2]),
        origin=float(terms[3]),
        shift_noise=rows.shift_noise,
        load_noise=rows.load_noise,
    )


def _passes(
    rows: _Rows, log_friction: float, terms: Array, end: float, limit: float
) -> float | None:
    """ln f between the best and `end` at which the sum of squares passes `limit`; None where it
    does not.
    """
    state = {"terms": terms}

    def beyond(place: float) -> float:
        total, state["terms"] = rows.best_terms(math.exp(place), state["terms"])
        return total - limit

    side = 1.0 if end > log_friction else -1.0
    # The sum of squares is nearly a parabola: its rise at a step says how far the limit is.
    at_best = beyond(log_friction)
    step = min(1e-3, abs(end - log_friction) / 2)
    rise = max(beyond(log_friction + side * step) - at_best, 1e-300)
    step *= math.sqrt(max(-at_best / rise, 1e-8))
    inner = log_friction
    for _ in range(_STEPS):
        outer = log_friction + side * min(step, abs(end - log_friction))
        if beyond(outer) > 0:
            for _ in range(_HALVED):
                middle = (inner + outer) / 2
                if beyond(middle) > 0:
                    outer = middle
                else:
                    inner = middle
            return outer
        if outer == end:
            return None
        inner = outer
        step *= 1.3
    return None


# ----------------------------------------------------------------------------------------- the area
@dataclass(frozen=True)
class LoopArea:
    """Area of the polygon of the rows, the mean of whole cycles [energy per thickness], and what it
    is uncertain by.

    Attributes
    ----------
    by_distance : of the rows from each other: a polygon of twice the step errs four times as much.
        That is three times the error; half of the difference is stated
    by_noise : 1.96 standard deviations, from the scatter of U and Q
    """

    value: float
    by_distance: float
    by_noise: float
    cycles: int

    @property
    def uncertainty(self) -> float:
        """Both together."""
        return math.hypot(self.by_distance, self.by_noise)


def _shoelace(shift: Array, load: Array) -> float:
    """Closed integral of Q dU along the polygon (n,) and (n,), which ends where it begins."""
    return float(np.sum((load + np.roll(load, -1)) / 2 * (np.roll(shift, -1) - shift)))


def polygon_area(
    shift: Array, load: Array, phase: Array, shift_noise: float, load_noise: float
) -> LoopArea:
    """Area of the polygon through rows in their order, over as many whole cycles as they cover.

    Parameters
    ----------
    shift, load : U and Q, (n,) each
    phase : (n,) cycles since any instant
    shift_noise, load_noise : sigma of U and Q

    >>> angle = 2 * np.pi * np.arange(100) / 100
    >>> found = polygon_area(-np.sin(angle), np.cos(angle), angle / (2 * np.pi), 0.0, 0.0)
    >>> abs(found.value + np.pi) < found.by_distance < 0.01
    True
    """
    covered = float(phase[-1] - phase[0])
    # A row is missing where the last one is a step before the first; phases are known to a
    # hundredth.
    missing = 1.6 * covered / (len(phase) - 1) + 0.01
    cycles = max(math.floor(covered + missing), 1)
    end = float(phase[0]) + cycles
    reached = np.flatnonzero(phase >= end)
    reached = reached[reached > 0.5 * len(phase) * cycles / max(covered, cycles)]
    by_gap = 0.0
    if len(reached):  # up to the place between two rows where the loop closes
        after = int(reached[0])
        share = float(
            np.clip(
                (end - phase[after - 1]) / max(phase[after] - phase[after - 1], 1e-300), 0.0, 1.0
            )
        )
        ends = [
            float(values[after - 1] + share * (values[after] - values[after - 1]))
            for values in (shift, load)
        ]
        shift, load = np.append(shift[:after], ends[0]), np.append(load[:after], ends[1])
    elif (
        end - phase[-1] > missing
    ):  # the loop may lie anywhere between the chord and its end tangents
        by_gap = abs(float((shift[-1] - shift[0]) * (load[-1] - load[0]))) / 2
    value = _shoelace(shift, load)
    coarse = (_shoelace(shift[::2], load[::2]) + _shoelace(shift[1::2], load[1::2])) / 2
    across = (np.roll(shift, -1) - np.roll(shift, 1)) / 2
    step = (np.roll(load, -1) - np.roll(load, 1)) / 2
    scatter = math.sqrt(float(np.sum((shift_noise * step) ** 2 + (load_noise * across) ** 2)))
    by_distance = abs(value - coarse) / 2 + by_gap
    return LoopArea(value / cycles, by_distance / cycles, 1.96 * scatter / cycles, cycles)
