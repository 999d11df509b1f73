"""Which loop of Masing's rule follows the rows of a measured one best, and the interval of its f.

# notation: f friction coefficient, Q load, R range of Q, S gross slide of U at each end, sigma
#           standard deviation of the noise of a row, U relative displacement

Least squares over all parameters of the loop (`loop_masing`) of the distances of the rows from the
nearest points of it, in sigma of U and of Q; the better of the best partial and the best gross
loop. Sigma is found with the fit. The interval of f is where the least sum of squares at a given f
exceeds the least of all by what chance gives in 95 % (profile likelihood, with the F distribution
since sigma is estimated from the rows).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.scoring.loop_branches import row_noise
from reports.scoring.loop_fit import Weights
from reports.scoring.loop_masing import (
    COMPLIANCE,
    DRIFT_RATE,
    LOG_F,
    MIDDLE,
    ORIGIN,
    RANGE,
    SLIDE,
    Distances,
    MasingLoop,
    MeasuredRows,
    MemoryCurve,
    distances_from,
)
from reports.scoring.loop_steadiness import BY_CHANCE, Change, Misfit, change_of, misfit_of
from scenes.array_types import Array

# First trials of f, from just above gross sliding to so many times as much; beyond, a loop is a
# line. Trials of the slide, in ranges of U.
_TRIALS = 24
_ABOVE = 0.002
_WIDEST = 40.0
_SLIDES = (0.05, 0.2, 0.4, 0.6, 0.8)
# Minima among the trials of each kind from which a fit begins.
_MINIMA = 2
# A gauge drifts by up to 2 % of the range of U over the record, any part of it alike: a standard
# deviation of 2 %/sqrt(3). Rows of one cycle can't tell it from f.
_DRIFT = 0.0115
# Least error of a turning point of U and Q together, each over its range: parabolas describe a
# branch beside it no better.
_ERROR_OF_TURN = 0.002
# Mean square of distances, in variances of the last digits, up to which digits alone explain them.
_BY_DIGITS = 1.3
# Fits with the noise of the fit before: it changes by less than a part in twenty then.
_REWEIGHTED = 8
_SAME_NOISE = 0.05
# Largest scatter of ln(sigma of U/sigma of Q) about what neighbouring rows show.
_RATIO_OF_NOISE = 1.0
# Its scatter by chance, times the square root of rows: ln of either median scatters by 1.6.
_OF_ROW_NOISE = 2.3
# Noise of rows that show none, over their largest value: f is not known better than theory's
# samples leave it.
_LEAST_NOISE = 1e-9
# Steps outwards to the end of an interval, and by which it is narrowed then.
_STEPS = 30
_NARROWED = 12
# Lowest and highest f of an interval over the best one.
_FARTHEST = 60.0
# Excess of the sum of squares that is admitted of a loop of the other kind, over that of the same
# kind: chi squared of three degrees, f, slide and range, over that of one.
_OTHER_KIND = 7.815 / 3.841
# Share of a step of the digits of Q within which a plateau lies in 95 %, where no noise moves it
# from one digit to the next; noise of that share of a step does.
_OF_STEP = 0.475
_MOVES_DIGITS = 0.4


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
    influence
        (7, m) of the m residuals' scatter on the parameters: the rows' distances stand first
    freedom
        rows without the parameters
    by_digits
        error of f by the last digit of a plateau (95 %)
    ends
        parameters (7,) at either end of the interval of f, None where it has none
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
    influence: Array
    freedom: int
    by_digits: float
    ends: tuple[Array | None, Array | None]

    @property
    def highest(self) -> float:
        """Largest Q."""
        return float(self.values[MIDDLE] + self.values[RANGE] / 2)

    @property
    def lowest(self) -> float:
        """Smallest Q."""
        return float(self.values[MIDDLE] - self.values[RANGE] / 2)

    @property
    def compliance(self) -> float:
        """C [1/stress]."""
        return float(self.values[COMPLIANCE])

    @property
    def drift(self) -> float:
        """D over the whole record [length]."""
        return float(self.values[DRIFT_RATE])

    @property
    def drift_error(self) -> float:
        """Standard error of D [length]."""
        return float(self.errors[DRIFT_RATE])

    @property
    def slide(self) -> float:
        """S [length]."""
        return float(self.values[SLIDE])


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
        of_drift[0, DRIFT_RATE] = drift
        return (
            np.concatenate([found.value, turns, [values[DRIFT_RATE] * drift]]),
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
            of_shift_here[ORIGIN] = 1.0
            of_shift_here[DRIFT_RATE] = instant
            of_load_here = side * of_load[0]
            of_load_here[MIDDLE] = 1.0
            shift_here = side * shift[0] + values[ORIGIN] + values[DRIFT_RATE] * instant
            load_here = side * load[0] + values[MIDDLE]
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
            held.add(COMPLIANCE)
        if gross:
            held.add(RANGE)
        else:
            held.add(SLIDE)
        free = np.array([k for k in range(7) if k not in held])
        sizes = self.sizes

        def placed(steps: Array) -> Array:
            values = start.copy()
            values[free] += steps * sizes[free]
            values[LOG_F] = min(max(values[LOG_F], -30.0), 30.0)
            if gross:
                values[RANGE] = math.exp(values[LOG_F]) / self.curve.sliding
            return values

        latest: dict[bytes, tuple[Array, Array]] = {}

        def both(steps: Array) -> tuple[Array, Array]:
            key = steps.tobytes()
            if key not in latest:
                values = placed(steps)
                residuals, derivatives = self.residuals(values)
                if gross:  # R goes with ln f
                    derivatives[:, LOG_F] += values[RANGE] * derivatives[:, RANGE]
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
        extent = self.rows.sizes[MIDDLE]
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
            values[LOG_F] = math.log(self.curve.sliding * values[RANGE])
            squares, values = self.least(values, frozenset([SLIDE]), gross=True)
        if gross and values[SLIDE] < 0:
            values = values.copy()
            values[SLIDE] = 0.0
            squares, values = self.least(values, frozenset([SLIDE]), gross=True)
        return _Least(squares, values)

    def _beyond_sliding(self, values: Array) -> bool:
        return bool(math.exp(values[LOG_F]) < self.curve.sliding * values[RANGE])

    def at_friction(self, log_friction: float, start: Array, *, gross: bool) -> _Least:
        """The best loop of one kind at this f."""
        held = frozenset([LOG_F])
        values = start.copy()
        values[LOG_F] = log_friction
        if not gross:
            squares, values = self.least(values, held, gross=False)
            return _Least(math.inf if self._beyond_sliding(values) else squares, values)
        squares, values = self.least(values, held, gross=True)
        if values[SLIDE] < 0:
            values = values.copy()
            values[SLIDE] = 0.0
            squares, values = self.least(values, held | {SLIDE}, gross=True)
        return _Least(squares, values)

    def interval_end(
        self, fits: tuple[_Least, _Least], side: float, excess: float, step: float
    ) -> Array | None:
        """Parameters (7,) on this side (1 or -1) of the better fit at whose f the least sum of
        squares exceeds its own by `excess`; None where it does not. `fits` are the best partial and
        the best gross loop; of the worse kind more excess is admitted, since the kind was chosen by
        the rows too.
        """
        least, best = min(fits, key=lambda fit: fit.squares)
        gross_is_better = fits[1].squares < fits[0].squares
        latest = {gross: fit.values for gross, fit in zip((False, True), fits, strict=True)}
        first = gross_is_better

        def root_of_excess(log_trial: float) -> float:
            """1 where the sum of squares passes the limit; nearly linear in ln f."""
            nonlocal first
            smallest = math.inf
            for gross in (first, not first):
                fit = self.at_friction(log_trial, latest[gross], gross=gross)
                if math.isfinite(fit.squares):
                    latest[gross] = fit.values
                admitted = excess if gross == gross_is_better else _OTHER_KIND * excess
                share = max(fit.squares - least, 0.0) / admitted
                if share < smallest:
                    smallest = share
                    first = gross
                if smallest <= 1:  # whatever the other kind gives
                    break
            return math.sqrt(smallest)

        end = passes(root_of_excess, float(best[LOG_F]), side, step)
        if end is None:
            return None
        return self.at_friction(end, latest[first], gross=first).values


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
    least = np.log(np.array(smallest) / np.array(weights))
    answer = minimize(
        unlikely,
        np.maximum(common, least),
        method="Nelder-Mead",
        bounds=[(float(end), math.inf) for end in least],
        options={"xatol": 1e-3},
    )
    factors = np.exp(np.maximum(answer.x, least))
    return Weights(float(factors[0]) * weights.shift, float(factors[1]) * weights.load)


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
    def hangs_on_digits(self) -> bool:
        """Whether no noise moves the last digit of a plateau: its rows lie beside it together."""
        digits = _digits_of_plateau(self.search.rows, self.search.curve, self.search.weights)
        return self.gross and digits > 0

    def change_with(self, when: Array) -> Change:
        """How the loop changes with `when` (n,), a number of each row.

        U at the middle is left out: that it changes with time is drift.
        """
        free = _free_parameters(self.search.rows, gross=self.gross)
        columns = self._columns
        varying = np.isin(free, [ORIGIN, DRIFT_RATE], invert=True)
        centred = when - np.mean(when)
        return change_of(self.distances.value, columns, columns[:, varying] * centred[:, None])

    def change_of_size_with(self, when: Array) -> Change:
        """How much U and Q of the loop grow with `when` (n,), over themselves: two terms."""
        centred = when - np.mean(when)
        growth = self._columns_of_size * centred[:, None]
        return change_of(self.distances.value, self._columns, growth)

    def log_friction_at_end(self, growth: Array, when: Array) -> float:
        """Of ln f, by how much it changes if U and Q (2,) grow so with `when` (n,), and all rows
        are made as large as the last ones.
        """
        as_large_as_last = self._columns_of_size @ growth * (when - when[-1])
        influence = _influence(self.search, self.values, self.gross)
        return float(influence[LOG_F, : len(when)] @ as_large_as_last)

    def rise_along_slide(self) -> tuple[float, Change]:
        """By how much Q rises while the contact slides as a whole, over R; what it explains."""
        along = np.mod(self.distances.place, 1.0)
        side = np.where(self.distances.place > 1, -1.0, 1.0)
        share_of_slide = np.clip(2 * along - 1, 0.0, 1.0)
        of_load = self.values[RANGE] * side * share_of_slide
        column = -self.distances.across[:, 1] * of_load / self.search.weights.load
        change = change_of(self.distances.value, self._columns, column[:, None])
        return float(change.terms[0]), change

    @property
    def _columns(self) -> Array:
        """Derivatives (n, k) of the distances by the parameters that are fitted."""
        free = _free_parameters(self.search.rows, gross=self.gross)
        columns = _columns_of_fit(self.search, self.values, self.distances.derivatives, self.gross)
        return columns[:, free]

    @property
    def _columns_of_size(self) -> Array:
        """Derivatives (n, 2) of the distances by the sizes of U and of Q, over themselves."""
        loop = MasingLoop(self.search.curve, self.values)
        at_rows = np.column_stack(loop.at_rows(self.distances.place))
        return -self.distances.across * at_rows / np.array(self.search.weights)


def _misfit(found: Distances, weights: Weights, smallest: Weights) -> Misfit:
    """By neighbours in time, and by neighbours on the loop, which are of several cycles."""
    by_digits = found.across**2 @ (np.array(smallest) / np.array(weights)) ** 2
    digits_alone = float(np.mean(found.value**2)) < _BY_DIGITS * float(np.mean(by_digits))
    # Rows are rounded alike where they lie alike: no fault of the model, but fewer rows' worth,
    # and no chance either.
    least_deviations = 0.0 if digits_alone else BY_CHANCE
    order = np.argsort(found.place, kind="stable")
    inwards = np.where(found.place > 1, -1.0, 1.0) * found.value
    in_time = misfit_of(found.value, weights.shift, least_deviations)
    on_loop = misfit_of(inwards[order], weights.shift, least_deviations)
    misfit = max(in_time, on_loop, key=lambda misfit: misfit.correlation)
    return replace(misfit, systematic=0.0) if digits_alone else misfit


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
    influence = _influence(search, best.values, best.gross)
    errors = np.sqrt(variance * np.sum(influence**2, axis=1))
    widening = best.misfit.widening
    excess = float(fisher.ppf(0.95, 1, best.freedom)) * widening**2 * variance
    step = float(np.clip(2 * errors[LOG_F] * widening, 1e-9, 0.3))
    friction = math.exp(best.values[LOG_F])
    down = search.interval_end(best.fits, -1.0, excess, step)
    up = search.interval_end(best.fits, 1.0, excess, step)
    by_digits = 0.0
    if best.gross:
        by_digits = _digits_of_plateau(search.rows, search.curve, search.weights)
    own = math.hypot(friction * error_of_theory, by_digits)
    low = 0.0
    if down is not None:
        low = friction - math.hypot(friction - math.exp(down[LOG_F]), own)
    high = None
    if up is not None:
        high = friction + math.hypot(math.exp(up[LOG_F]) - friction, own)
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
        influence=influence,
        freedom=best.freedom,
        by_digits=by_digits,
        ends=(down, up),
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


def _influence(search: _Search, values: Array, gross: bool) -> Array:
    """Change of the parameters (7,) per unit of each residual (m,) in linear least squares."""
    free = _free_parameters(search.rows, gross=gross)
    columns = _columns_of_fit(search, values, search.residuals(values)[1], gross)[:, free]
    influence = np.zeros((7, len(columns)))
    influence[free] = -np.linalg.pinv(columns) * search.sizes[free][:, None]
    if gross:
        influence[RANGE] = values[RANGE] * influence[LOG_F]
    return influence


def _free_parameters(rows: MeasuredRows, *, gross: bool) -> NDArray[np.intp]:
    """Places of the parameters that are fitted: in a gross loop R goes with f."""
    held = {RANGE} if gross else {SLIDE}
    if rows.compliance is not None:
        held.add(COMPLIANCE)
    return np.array([k for k in range(7) if k not in held])


def _columns_of_fit(search: _Search, values: Array, derivatives: Array, gross: bool) -> Array:
    """Derivatives (n, 7) by the parameters over their sizes; where R goes with f, by both."""
    columns = derivatives.copy()
    if gross:
        columns[:, LOG_F] += values[RANGE] * columns[:, RANGE]
    return np.asarray(columns * search.sizes)
