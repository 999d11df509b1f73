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
    parameters
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
    parameters: Array
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
        return float(self.parameters[MIDDLE] + self.parameters[RANGE] / 2)

    @property
    def lowest(self) -> float:
        """Smallest Q."""
        return float(self.parameters[MIDDLE] - self.parameters[RANGE] / 2)

    @property
    def compliance(self) -> float:
        """C [1/stress]."""
        return float(self.parameters[COMPLIANCE])

    @property
    def drift(self) -> float:
        """D over the whole record [length]."""
        return float(self.parameters[DRIFT_RATE])

    @property
    def drift_error(self) -> float:
        """Standard error of D [length]."""
        return float(self.errors[DRIFT_RATE])

    @property
    def slide(self) -> float:
        """S [length]."""
        return float(self.parameters[SLIDE])


class _Least(NamedTuple):
    """A fit: its least sum of squares, and the parameters (7,) of the loop that gives it."""

    squares: float
    parameters: Array


@dataclass(frozen=True, eq=False)
class _Search:
    """Least squares of the distances of rows from a loop, of its turning points, and of the drift.

    A loop has seven parameters (7,): ln f, middle Q_mid and range R of Q, compliance C of the rig,
    U_mid, drift D of U, gross slide S (`loop_masing`). It is partial (S = 0), or gross: the contact
    slides as a whole at its ends, and R = 2 f P.
    """

    rows: MeasuredRows
    curve: MemoryCurve
    weights: Weights

    @property
    def sizes(self) -> Array:
        return self.rows.sizes

    def residuals(self, parameters: Array) -> tuple[Array, Array]:
        """Residuals of a loop with seven `parameters` (7,), each over its sigma, (n + 3,):
        distances of the n rows, misfit of both turning points, and the drift. With them their
        derivatives by the parameters, (n + 3, 7).

        The parameters are ln f, middle and range of Q, compliance C of the rig, origin of U, drift
        of U, gross slide.
        """
        distances = distances_from(self.rows, self.curve, parameters, self.weights)
        misfit_of_turns, derivatives_of_turns = self._turning_points(parameters)
        inverse_sigma_of_drift = 1 / (_DRIFT * float(np.ptp(self.rows.shift)))
        derivatives_of_drift = np.zeros((1, 7))
        derivatives_of_drift[0, DRIFT_RATE] = inverse_sigma_of_drift
        return (
            np.concatenate(
                [
                    distances.value,
                    misfit_of_turns,
                    [parameters[DRIFT_RATE] * inverse_sigma_of_drift],
                ]
            ),
            np.concatenate([distances.derivatives, derivatives_of_turns, derivatives_of_drift]),
        )

    def _turning_points(self, parameters: Array) -> tuple[Array, Array]:
        """Misfit of the two turning points of a loop to those of the rows, over sigma, (2,), the
        highest first; and its derivatives by the loop's seven `parameters`, (2, 7).

        A turning point is where the height U/(range of U) + Q/(range of Q) is largest or least; the
        misfit is a difference of heights.
        """
        rows = self.rows
        loop = MasingLoop(self.curve, parameters)
        # the rising branch ends at place 2; the falling one is the same, turned about the middle
        place_of_turn = np.array([2.0])
        shift_at_turn, load_at_turn = loop.points(place_of_turn)
        shift_gradient_at_end, load_gradient_at_end = loop.derivatives(place_of_turn)
        range_of_shift, range_of_load = rows.ranges
        residuals = np.zeros(2)
        derivatives = np.zeros((2, 7))
        turns_of_rows = (rows.branches.highest, rows.branches.lowest)
        for k, (turn, sign_of_turn, mean_time) in enumerate(
            zip(turns_of_rows, (1.0, -1.0), rows.instants_of_turns, strict=True)
        ):
            shift_gradient = sign_of_turn * shift_gradient_at_end[0]
            shift_gradient[ORIGIN] = 1.0
            shift_gradient[DRIFT_RATE] = mean_time
            load_gradient = sign_of_turn * load_gradient_at_end[0]
            load_gradient[MIDDLE] = 1.0
            shift_of_loop = (
                sign_of_turn * shift_at_turn[0]
                + parameters[ORIGIN]
                + parameters[DRIFT_RATE] * mean_time
            )
            load_of_loop = sign_of_turn * load_at_turn[0] + parameters[MIDDLE]
            height_of_loop = shift_of_loop / range_of_shift + load_of_loop / range_of_load
            error_of_height = max(turn.error, _ERROR_OF_TURN)
            height_of_rows = turn.load  # `MeasuredRows.branches`: found in heights, not in Q
            residuals[k] = (height_of_loop - height_of_rows) / error_of_height
            derivatives[k] = shift_gradient / range_of_shift + load_gradient / range_of_load
            derivatives[k] /= error_of_height
        return residuals, derivatives

    def sum_of_squares(self, parameters: Array) -> float:
        """Of the residuals."""
        distances = self.residuals(parameters)[0]
        return float(distances @ distances)

    def least(self, start: Array, fixed: frozenset[int], *, gross: bool) -> tuple[float, Array]:
        """Fit the seven parameters of a loop by least squares from `start` (7,): ln f, middle and
        range of Q, compliance C of the rig, origin of U, drift of U, gross slide. Returns the least
        sum of squares, and the parameters (7,) that give it.

        Parameters
        ----------
        fixed
            indices of parameters that are not fitted
        gross
            whether the contact slides as a whole at the ends of the loop: f then follows from the
            range of Q, and the slide is fitted
        """
        from scipy.optimize import least_squares

        held_parameters = set(fixed)
        if self.rows.compliance is not None:
            held_parameters.add(COMPLIANCE)
        if gross:
            held_parameters.add(RANGE)
        else:
            held_parameters.add(SLIDE)
        free_parameters = np.array([k for k in range(7) if k not in held_parameters])
        typical_sizes = self.sizes

        def parameters_at(steps: Array) -> Array:
            """All seven parameters: the free ones are moved by `steps`, in units of their sizes."""
            parameters = start.copy()
            parameters[free_parameters] += steps * typical_sizes[free_parameters]
            parameters[LOG_F] = min(max(parameters[LOG_F], -30.0), 30.0)
            if gross:
                parameters[RANGE] = math.exp(parameters[LOG_F]) / self.curve.sliding
            return parameters

        # the method asks for residuals and derivatives in turn: both are kept of the latest
        # parameters
        computed_last: dict[bytes, tuple[Array, Array]] = {}

        def residuals_and_derivatives(steps: Array) -> tuple[Array, Array]:
            """Residuals over sigma (m,), and their derivatives by `steps`, (m, free parameters)."""
            steps_as_bytes = steps.tobytes()
            if steps_as_bytes not in computed_last:
                parameters = parameters_at(steps)
                residuals, derivatives = self.residuals(parameters)
                if gross:  # the range R of Q follows from ln f: R = 2 f P
                    derivatives[:, LOG_F] += parameters[RANGE] * derivatives[:, RANGE]
                computed_last.clear()
                computed_last[steps_as_bytes] = (
                    residuals,
                    derivatives[:, free_parameters] * typical_sizes[free_parameters],
                )
            return computed_last[steps_as_bytes]

        minimum = least_squares(
            lambda steps: residuals_and_derivatives(steps)[0],
            np.zeros(len(free_parameters)),
            jac=lambda steps: residuals_and_derivatives(steps)[1],
            method="lm",
            xtol=1e-8,
            ftol=1e-10,
            max_nfev=60,
        )
        return 2 * float(minimum.cost), parameters_at(minimum.x)

    def start(self, log_friction: float, slide_fraction: float) -> Array:
        """Parameters (7,) from which a fit begins: ln f, middle and range of Q, compliance C of the
        rig, origin of U, drift of U (0), gross slide.

        C is such that theory's U plus C Q ranges as far as U of the rows. f of a gross loop
        follows from the range of Q, since f P is half of it.

        Parameters
        ----------
        log_friction
            ln f of a partial loop; not used in a gross one
        slide_fraction
            range of U that is gross slide, over the whole range of U; 0 for a partial loop
        """
        rows = self.rows
        high_load, low_load = np.quantile(rows.load, [0.98, 0.02])
        range_of_load = float(high_load - low_load)
        if slide_fraction > 0:
            log_friction = math.log(self.curve.sliding * range_of_load)
        friction = math.exp(log_friction)
        range_of_shift = float(np.ptp(np.quantile(rows.shift, [0.01, 0.99])))
        range_of_theory_shift = (
            2 * friction * float(self.curve.value(np.array(range_of_load / 2 / friction)))
        )
        compliance = rows.compliance
        if compliance is None:
            compliance = (
                (1 - slide_fraction) * range_of_shift - range_of_theory_shift
            ) / range_of_load
        middle_of_shift = float(np.mean(np.quantile(rows.shift, [0.02, 0.98])))
        return np.array(
            [
                log_friction,
                (high_load + low_load) / 2,
                range_of_load,
                compliance,
                middle_of_shift,
                0.0,
                slide_fraction * range_of_shift,
            ]
        )

    def best(self) -> tuple[_Least, _Least]:
        """The best partial loop for the rows, and the best gross one (the contact slides as a whole
        at its ends). Each kind begins from many trials; the lowest local minima among these are
        refined.
        """
        high_load, low_load = np.quantile(self.rows.load, [0.98, 0.02])
        log_least_friction = math.log(self.curve.sliding * float(high_load - low_load))
        log_frictions = (
            log_least_friction
            + np.linspace(math.sqrt(_ABOVE), math.sqrt(math.log(_WIDEST)), _TRIALS) ** 2
        )
        partial_starts = [self.start(log_friction, 0.0) for log_friction in log_frictions.tolist()]
        gross_starts = [self.start(0.0, slide) for slide in _SLIDES]
        best_fits = []
        for starts, is_gross in ((partial_starts, False), (gross_starts, True)):
            sums_of_squares = np.array([self.sum_of_squares(start) for start in starts])
            sums_with_walls = np.concatenate([[math.inf], sums_of_squares, [math.inf]])
            local_minima = np.flatnonzero(
                (sums_of_squares <= sums_with_walls[:-2]) & (sums_of_squares <= sums_with_walls[2:])
            )
            lowest_minima = local_minima[np.argsort(sums_of_squares[local_minima])][:_MINIMA]
            fits = [
                self._within(*self.least(starts[k], frozenset(), gross=is_gross), gross=is_gross)
                for k in lowest_minima.tolist()
            ]
            best_fits.append(min(fits, key=lambda fit: fit.squares))
        return best_fits[0], best_fits[1]

    def again(self, partial: _Least, gross: _Least) -> tuple[_Least, _Least]:
        """The best partial and the best gross loop from parameters near them."""
        return (
            self._within(*self.least(partial.parameters, frozenset(), gross=False), gross=False),
            self._within(*self.least(gross.parameters, frozenset(), gross=True), gross=True),
        )

    def _within(self, squares: float, parameters: Array, *, gross: bool) -> _Least:
        """A fit, at the wall between partial and gross loops where it lies beyond."""
        if not gross and self._beyond_sliding(parameters):
            parameters = parameters.copy()
            parameters[LOG_F] = math.log(self.curve.sliding * parameters[RANGE])
            squares, parameters = self.least(parameters, frozenset([SLIDE]), gross=True)
        if gross and parameters[SLIDE] < 0:
            parameters = parameters.copy()
            parameters[SLIDE] = 0.0
            squares, parameters = self.least(parameters, frozenset([SLIDE]), gross=True)
        return _Least(squares, parameters)

    def _beyond_sliding(self, parameters: Array) -> bool:
        return bool(math.exp(parameters[LOG_F]) < self.curve.sliding * parameters[RANGE])

    def at_friction(self, log_friction: float, start: Array, *, gross: bool) -> _Least:
        """The best loop at a given coefficient of friction f, `log_friction` = ln f: the best gross
        loop if `gross`, else the best partial one. `start` (7,) are the parameters from which it is
        sought.

        The sum of squares of a partial loop is infinite where its contact would slide as a whole.
        """
        held_parameters = frozenset([LOG_F])
        parameters = start.copy()
        parameters[LOG_F] = log_friction
        if not gross:
            squares, parameters = self.least(parameters, held_parameters, gross=False)
            return _Least(math.inf if self._beyond_sliding(parameters) else squares, parameters)
        squares, parameters = self.least(parameters, held_parameters, gross=True)
        if parameters[SLIDE] < 0:
            parameters = parameters.copy()
            parameters[SLIDE] = 0.0
            squares, parameters = self.least(parameters, held_parameters | {SLIDE}, gross=True)
        return _Least(squares, parameters)

    def interval_end(
        self, fits: tuple[_Least, _Least], side: float, excess: float, first_step: float
    ) -> Array | None:
        """One end of the 95 % interval of f: the seven parameters (7,) of the loop at the f where
        the least sum of squares exceeds that of the better fit by `excess`. None where it never
        does.

        Parameters
        ----------
        fits
            the best partial loop, and the best gross one. Loops of the worse kind are admitted with
            more excess, since the rows chose between the two kinds
        side
            1 for the upper end, -1 for the lower one
        excess
            admitted rise of the sum of squares
        first_step
            first step in ln f
        """
        sum_of_best_fit, best_parameters = min(fits, key=lambda fit: fit.squares)
        gross_is_better = fits[1].squares < fits[0].squares
        parameters_by_kind = {
            gross: fit.parameters for gross, fit in zip((False, True), fits, strict=True)
        }
        nearest_kind_is_gross = gross_is_better

        def root_of_relative_rise(log_trial: float) -> float:
            """Root of the rise of the least sum of squares over its admitted rise, at ln f =
            `log_trial`: 0 at the best f, 1 at the end of the interval, nearly linear in between.
            """
            nonlocal nearest_kind_is_gross
            least_relative_rise = math.inf
            for gross in (nearest_kind_is_gross, not nearest_kind_is_gross):
                fit = self.at_friction(log_trial, parameters_by_kind[gross], gross=gross)
                if math.isfinite(fit.squares):
                    parameters_by_kind[gross] = fit.parameters
                # a loop of the other kind than the best fit is admitted with more
                admitted_rise = excess if gross == gross_is_better else _OTHER_KIND * excess
                relative_rise = max(fit.squares - sum_of_best_fit, 0.0) / admitted_rise
                if relative_rise < least_relative_rise:
                    least_relative_rise = relative_rise
                    nearest_kind_is_gross = gross
                if least_relative_rise <= 1:  # within the interval, whatever the other kind gives
                    break
            return math.sqrt(least_relative_rise)

        log_friction_at_end = where_function_reaches_one(
            root_of_relative_rise, float(best_parameters[LOG_F]), side, first_step
        )
        if log_friction_at_end is None:
            return None
        return self.at_friction(
            log_friction_at_end,
            parameters_by_kind[nearest_kind_is_gross],
            gross=nearest_kind_is_gross,
        ).parameters


def where_function_reaches_one(
    function: Callable[[float], float], begin: float, direction: float, step: float
) -> float | None:
    """The x at which a function that grows from 0 at x = `begin` reaches 1, to 1 % of the distance
    from `begin`: steps outwards, then false position between the last two.

    None where it stays below 1 as far as ln 60 from `begin` (x is ln f: 60 times as much friction).

    Parameters
    ----------
    begin
        x at which the function is 0
    direction
        1 for x above `begin`, -1 below
    step
        first distance tried

    Examples
    --------
    >>> end = where_function_reaches_one(lambda x: 2 * abs(x), 0.0, 1.0, 0.3)
    >>> abs(end - 0.5) < 0.005
    True
    """
    distance_within = 0.0
    value_within = 0.0
    for _ in range(_STEPS):
        distance_beyond = distance_within + min(step, 0.5)
        value_beyond = function(begin + direction * distance_beyond)
        if value_beyond > 1:
            break
        if distance_beyond > math.log(_FARTHEST):
            return None
        step = 1.3 * distance_beyond * (1 / max(value_beyond, 0.1)) - distance_beyond
        distance_within = distance_beyond
        value_within = value_beyond
    else:
        return None
    for _ in range(_NARROWED):
        if distance_beyond - distance_within < 0.01 * distance_beyond:
            break
        fraction_by_secant = (1 - value_within) / (min(value_beyond, 1e6) - value_within)
        fraction = float(np.clip(fraction_by_secant, 0.1, 0.9))
        distance_between = distance_within + fraction * (distance_beyond - distance_within)
        value_between = function(begin + direction * distance_between)
        if abs(value_between - 1) < 0.01:
            return begin + direction * distance_between
        if value_between > 1:
            distance_beyond = distance_between
            value_beyond = value_between
        else:
            distance_within = distance_between
            value_within = value_between
    return begin + direction * distance_beyond


def _noise_of_rows(
    distances: Distances,
    weights: Weights,
    least_noise: Weights,
    degrees_of_freedom: int,
    log_noise_ratio: tuple[float, float],
) -> Weights:
    """Standard deviations (sigma) of U and of Q that make the distances of the rows from a fitted
    loop most likely.

    Parameters
    ----------
    distances
        distances of the rows, over the sigma in `weights`, with the unit normals of the loop
    weights
        sigma of U and of Q so far
    least_noise
        least sigma of U and Q, by the digits of the rows
    degrees_of_freedom
        rows minus fitted parameters
    log_noise_ratio
        ln(sigma of U/sigma of Q) that neighbouring rows show, and its scatter
    """
    # a factor is that by which sigma of U or of Q changes
    expected_log_ratio = log_noise_ratio[0] - math.log(weights.shift / weights.load)
    from scipy.optimize import minimize

    squared_distances = distances.value**2 * len(distances.value) / degrees_of_freedom
    squared_normals = distances.unit_normal**2

    def minus_log_likelihood(log_factors: Array) -> float:
        variance = squared_normals @ np.exp(2 * log_factors)
        prior = (
            float((log_factors[0] - log_factors[1] - expected_log_ratio) ** 2)
            / log_noise_ratio[1] ** 2
        )
        return float(np.sum(squared_distances / variance + np.log(variance))) + prior

    log_of_common_factor = math.log(max(math.sqrt(float(np.mean(squared_distances))), 1e-12))
    least_log_factors = np.log(np.array(least_noise) / np.array(weights))
    minimum = minimize(
        minus_log_likelihood,
        np.maximum(log_of_common_factor, least_log_factors),
        method="Nelder-Mead",
        bounds=[(float(least_log), math.inf) for least_log in least_log_factors],
        options={"xatol": 1e-3},
    )
    factors = np.exp(np.maximum(minimum.x, least_log_factors))
    return Weights(float(factors[0]) * weights.shift, float(factors[1]) * weights.load)


def _better(fits: tuple[_Least, _Least]) -> _Least:
    return min(fits, key=lambda fit: fit.squares)


@dataclass(frozen=True, eq=False)
class BestLoop:
    """The loop that follows rows best, before its interval is sought.

    Attributes
    ----------
    parameters
        (7,) its parameters
    gross
        whether the contact slides as a whole at its ends
    distances, misfit
        of the rows, and what they show
    """

    search: _Search
    fits: tuple[_Least, _Least]
    parameters: Array
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
        influence = _influence(self.search, self.parameters, self.gross)
        return float(influence[LOG_F, : len(when)] @ as_large_as_last)

    def rise_along_slide(self) -> tuple[float, Change]:
        """By how much Q rises while the contact slides as a whole, over R; what it explains."""
        along = np.mod(self.distances.place, 1.0)
        side = np.where(self.distances.place > 1, -1.0, 1.0)
        share_of_slide = np.clip(2 * along - 1, 0.0, 1.0)
        of_load = self.parameters[RANGE] * side * share_of_slide
        column = -self.distances.unit_normal[:, 1] * of_load / self.search.weights.load
        change = change_of(self.distances.value, self._columns, column[:, None])
        return float(change.terms[0]), change

    @property
    def _columns(self) -> Array:
        """Derivatives (n, k) of the distances by the parameters that are fitted."""
        free = _free_parameters(self.search.rows, gross=self.gross)
        columns = _columns_of_fit(
            self.search, self.parameters, self.distances.derivatives, self.gross
        )
        return columns[:, free]

    @property
    def _columns_of_size(self) -> Array:
        """Derivatives (n, 2) of the distances by the sizes of U and of Q, over themselves."""
        loop = MasingLoop(self.search.curve, self.parameters)
        at_rows = np.column_stack(loop.at_rows(self.distances.place))
        return -self.distances.unit_normal * at_rows / np.array(self.search.weights)


def _misfit_of_loop(distances: Distances, weights: Weights, least_noise: Weights) -> Misfit:
    """Whether neighbouring rows lie on the same side of the fitted loop, so that their distances
    are more than scatter.

    Neighbours in time and neighbours along the loop, which are of several cycles, are both tried;
    the larger correlation counts. Where the digits of the rows explain the distances nothing is
    systematic.

    Parameters
    ----------
    weights
        sigma of U and of Q with which the distances were taken
    least_noise
        sigma that the digits of the rows leave
    """
    variance_by_digits = distances.unit_normal**2 @ (np.array(least_noise) / np.array(weights)) ** 2
    digits_explain_all = float(np.mean(distances.value**2)) < _BY_DIGITS * float(
        np.mean(variance_by_digits)
    )
    # Neighbours on the loop are rounded alike. That is no fault of the model, but they count as
    # fewer rows, and any correlation counts: it is no chance.
    least_significance = 0.0 if digits_explain_all else BY_CHANCE
    order_on_loop = np.argsort(distances.place, kind="stable")
    # positive inside the loop on both branches: to the right of the rising one, left of the falling
    distance_to_inside = np.where(distances.place > 1, -1.0, 1.0) * distances.value
    misfit_in_time = misfit_of(distances.value, weights.shift, least_significance)
    misfit_on_loop = misfit_of(distance_to_inside[order_on_loop], weights.shift, least_significance)
    larger_misfit = max(misfit_in_time, misfit_on_loop, key=lambda misfit: misfit.correlation)
    return replace(larger_misfit, systematic=0.0) if digits_explain_all else larger_misfit


def best_loop(rows: MeasuredRows, curve: MemoryCurve) -> BestLoop:
    """Find the loop that fits the rows best, of those that slip partially or slide as a whole
    (gross), with the noise of U and Q. Fit and noise are found by turns until the noise no longer
    changes.

    `curve` is the memory curve of theory at constant P: U over half the change of Q since a turning
    point, from which loops are built (Masing's rule).
    """
    least_noise = Weights(
        *(
            max(step / math.sqrt(12), _LEAST_NOISE * float(np.max(np.abs(values_of_rows))))
            for step, values_of_rows in zip(rows.resolution, (rows.shift, rows.load), strict=True)
        )
    )
    weights = Weights(
        max(row_noise(rows.shift), least_noise.shift), max(row_noise(rows.load), least_noise.load)
    )
    search = _Search(rows, curve, weights)
    degrees_of_freedom = len(rows.shift) - 6 - (rows.compliance is None)
    fits = search.best()
    log_noise_ratio = (math.log(weights.shift / weights.load), _RATIO_OF_NOISE)
    for times_reweighted in range(_REWEIGHTED):
        distances = distances_from(rows, curve, _better(fits).parameters, search.weights)
        if times_reweighted == 0:
            # Where the first fit leaves what neighbouring rows show, they show noise alone.
            scatter_by_fit = abs(math.log(max(float(np.std(distances.value)), 1e-9)))
            least_scatter = _OF_ROW_NOISE / math.sqrt(len(rows.shift))
            log_noise_ratio = (
                log_noise_ratio[0],
                min(max(scatter_by_fit, least_scatter), _RATIO_OF_NOISE),
            )
        weights = _noise_of_rows(
            distances, search.weights, least_noise, degrees_of_freedom, log_noise_ratio
        )
        changes = np.array(weights) / np.array(search.weights) - 1
        if np.max(np.abs(changes)) < _SAME_NOISE:
            break
        search = replace(search, weights=weights)
        # With another noise another minimum may be the lowest.
        fits = search.best() if times_reweighted == 0 else search.again(*fits)
    parameters = _better(fits).parameters
    distances = distances_from(rows, curve, parameters, search.weights)
    return BestLoop(
        search=search,
        fits=fits,
        parameters=parameters,
        gross=fits[1].squares < fits[0].squares,
        distances=distances,
        misfit=_misfit_of_loop(distances, search.weights, least_noise),
        freedom=degrees_of_freedom,
    )


def with_interval(best_loop: BestLoop, error_of_theory: float) -> MasingFit:
    """The best fit of a measured loop with its 95 % interval of the coefficient of friction f: up
    to where the least sum of squares rises by what the F distribution admits. The interval is
    widened where neighbouring rows lie on the same side of the loop (`Misfit.widening`), and by
    errors that more rows would not lessen.

    A loop is gross where the contact slides as a whole at its ends, else partial. `high` of the
    answer is None where the rows do not bound f from above: the sum of squares never rises so far.

    Parameters
    ----------
    best_loop
        the loop: its parameters, the fits of the best partial and the best gross loop with their
        least sums of squares, and the search, which holds the rows and seeks other fits to them
    error_of_theory
        error of a fitted f, over f, since theory's memory curve is interpolated between samples
    """
    from scipy.stats import f as f_distribution

    search = best_loop.search
    partial_and_gross_fit = best_loop.fits
    variance = max(_better(partial_and_gross_fit).squares / best_loop.freedom, 1.0)
    # what a change of each residual by its sigma changes in the parameters
    influence = _influence(search, best_loop.parameters, best_loop.gross)
    standard_errors = np.sqrt(variance * np.sum(influence**2, axis=1))
    widening = best_loop.misfit.widening
    admitted_rise = float(f_distribution.ppf(0.95, 1, best_loop.freedom)) * widening**2 * variance
    first_step = float(np.clip(2 * standard_errors[LOG_F] * widening, 1e-9, 0.3))
    friction = math.exp(best_loop.parameters[LOG_F])
    parameters_at_lower_end = search.interval_end(
        partial_and_gross_fit, -1.0, admitted_rise, first_step
    )
    parameters_at_upper_end = search.interval_end(
        partial_and_gross_fit, 1.0, admitted_rise, first_step
    )
    # of f: the plateaus of a gross loop, at f P, are rounded to the last digit of Q
    error_by_last_digit = 0.0
    if best_loop.gross:
        error_by_last_digit = _digits_of_plateau(search.rows, search.curve, search.weights)
    # error of f that more rows would not lessen
    error_beside_scatter = math.hypot(friction * error_of_theory, error_by_last_digit)
    lowest_friction = 0.0
    if parameters_at_lower_end is not None:
        lowest_friction = friction - math.hypot(
            friction - math.exp(parameters_at_lower_end[LOG_F]), error_beside_scatter
        )
    highest_friction = None
    if parameters_at_upper_end is not None:
        highest_friction = friction + math.hypot(
            math.exp(parameters_at_upper_end[LOG_F]) - friction, error_beside_scatter
        )
    return MasingFit(
        friction=friction,
        low=max(lowest_friction, 0.0),
        high=highest_friction,
        parameters=best_loop.parameters,
        errors=standard_errors,
        gross=best_loop.gross,
        weights=search.weights,
        distances=best_loop.distances,
        misfit=best_loop.misfit,
        influence=influence,
        freedom=best_loop.freedom,
        by_digits=error_by_last_digit,
        ends=(parameters_at_lower_end, parameters_at_upper_end),
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


def _influence(search: _Search, parameters: Array, gross: bool) -> Array:
    """Change of the parameters (7,) per unit of each residual (m,) in linear least squares."""
    free = _free_parameters(search.rows, gross=gross)
    columns = _columns_of_fit(search, parameters, search.residuals(parameters)[1], gross)[:, free]
    influence = np.zeros((7, len(columns)))
    influence[free] = -np.linalg.pinv(columns) * search.sizes[free][:, None]
    if gross:
        influence[RANGE] = parameters[RANGE] * influence[LOG_F]
    return influence


def _free_parameters(rows: MeasuredRows, *, gross: bool) -> NDArray[np.intp]:
    """Places of the parameters that are fitted: in a gross loop R goes with f."""
    held = {RANGE} if gross else {SLIDE}
    if rows.compliance is not None:
        held.add(COMPLIANCE)
    return np.array([k for k in range(7) if k not in held])


def _columns_of_fit(search: _Search, parameters: Array, derivatives: Array, gross: bool) -> Array:
    """Derivatives (n, 7) by the parameters over their sizes; where R goes with f, by both."""
    columns = derivatives.copy()
    if gross:
        columns[:, LOG_F] += parameters[RANGE] * columns[:, RANGE]
    return np.asarray(columns * search.sizes)
