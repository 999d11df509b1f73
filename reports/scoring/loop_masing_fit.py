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

from reports.scoring.loop_branches import row_noise
from reports.scoring.loop_fit import RowNoise, noise_of_last_digits
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
    distances_from_loop,
)
from reports.scoring.loop_steadiness import (
    MOST_DEVIATIONS_BY_CHANCE,
    ExplainedChange,
    Misfit,
    explained_change,
    misfit_of,
)
from scenes.array_types import Array

# First trials of f: their number, and ln of the first and f of the last over f of gross sliding;
# beyond the last a loop is a line. Trials of the slide, in ranges of U.
_N_TRIALS = 24
_LEAST_LOG_RATIO = 0.002
_LARGEST_TRIAL_RATIO = 40.0
_SLIDE_FRACTIONS = (0.05, 0.2, 0.4, 0.6, 0.8)
# Minima among the trials of each kind from which a fit begins.
_N_MINIMA = 2
# A gauge drifts by up to 2 % of the range of U over the record, any part of it alike: a standard
# deviation of 2 %/sqrt(3). Rows of one cycle can't tell it from f.
_SIGMA_OF_DRIFT = 0.0115
# Least error of a turning point of U and Q together, each over its range: parabolas describe a
# branch beside it no better.
_LEAST_ERROR_OF_TURN = 0.002
# Mean square of distances, in variances of the last digits, up to which digits alone explain them.
_LARGEST_MEAN_SQUARE_BY_DIGITS = 1.3
# Fits with the noise of the fit before, at most; the relative change of the noise that ends them.
_MOST_REWEIGHTINGS = 8
_LARGEST_CHANGE_OF_SAME_NOISE = 0.05
# Largest scatter of ln(sigma of U/sigma of Q) about what neighbouring rows show.
_LARGEST_SCATTER_OF_NOISE_RATIO = 1.0
# Its scatter by chance, times the square root of rows: ln of either median scatters by 1.6.
_SCATTER_OF_ROW_NOISE = 2.3
# Steps outwards to the end of an interval, and steps by which it is narrowed then, at most.
_MOST_STEPS = 30
_MOST_NARROWINGS = 12
# Largest f at which the end of an interval is sought, over the best one; its inverse for the least.
_LARGEST_FRICTION_RATIO = 60.0
# Excess of the sum of squares that is admitted of a loop of the other kind, over that of the same
# kind: chi squared of three degrees, f, slide and range, over that of one.
_EXCESS_OF_OTHER_KIND = 7.815 / 3.841
# Share of a step of the digits of Q within which a plateau lies in 95 %, where no noise moves it
# from one digit to the next; noise of that share of a step does.
_SHARE_OF_STEP = 0.475
_LEAST_NOISE_THAT_CHANGES_DIGITS = 0.4


@dataclass(frozen=True, eq=False)
class MasingFit:
    """The loop that follows the rows best, with the 95 % interval of its f.

    Attributes
    ----------
    friction, lowest_friction, highest_friction
        f and its 95 % interval; the highest is None where the rows exclude no larger f
    parameters
        (7,) ln f, Q_mid, R, C, U_mid, D over the record, S
    standard_errors
        (7,) of the parameters
    is_gross
        whether the contact slides as a whole at the ends of the loop
    sigma
        standard deviation of the noise of U and of Q
    distances
        of the rows from the loop
    misfit
        correlation of the distances of neighbouring rows, and their systematic part
    influence
        (7, m) change of each parameter per unit of each of the m residuals: the distances of the
        rows stand first
    degrees_of_freedom
        number of rows minus number of fitted parameters
    error_by_digits
        error of f by the last digit of a plateau of Q (95 %)
    interval_ends
        parameters (7,) of the loops at the lower and the upper end of the interval of f, None
        where it has no such end
    """

    friction: float
    lowest_friction: float
    highest_friction: float | None
    parameters: Array
    standard_errors: Array
    is_gross: bool
    sigma: RowNoise
    distances: Distances
    misfit: Misfit
    influence: Array
    degrees_of_freedom: int
    error_by_digits: float
    interval_ends: tuple[Array | None, Array | None]

    @property
    def highest_load(self) -> float:
        """Largest Q, at the upper turning point [force per thickness]."""
        return float(self.parameters[MIDDLE] + self.parameters[RANGE] / 2)

    @property
    def lowest_load(self) -> float:
        """Smallest Q, at the lower turning point [force per thickness]."""
        return float(self.parameters[MIDDLE] - self.parameters[RANGE] / 2)

    @property
    def compliance(self) -> float:
        """Compliance C of the rig [1/stress]."""
        return float(self.parameters[COMPLIANCE])

    @property
    def drift(self) -> float:
        """Drift D of U over the whole record [length]."""
        return float(self.parameters[DRIFT_RATE])

    @property
    def drift_error(self) -> float:
        """Standard error of D [length]."""
        return float(self.standard_errors[DRIFT_RATE])

    @property
    def slide(self) -> float:
        """Gross slide S at each end of the loop [length]."""
        return float(self.parameters[SLIDE])


class _LeastSquaresFit(NamedTuple):
    """A fit: its least sum of squares, and the parameters (7,) of the loop that gives it."""

    sum_of_squares: float
    parameters: Array


class _FitsOfBothKinds(NamedTuple):
    """The best partial loop for the rows, and the best gross one."""

    partial_fit: _LeastSquaresFit
    gross_fit: _LeastSquaresFit

    @property
    def is_gross_better(self) -> bool:
        """Whether the gross loop lies nearer to the rows."""
        return self.gross_fit.sum_of_squares < self.partial_fit.sum_of_squares

    @property
    def better_fit(self) -> _LeastSquaresFit:
        """The loop that lies nearer to the rows."""
        return self.gross_fit if self.is_gross_better else self.partial_fit


@dataclass(frozen=True, eq=False)
class _Search:
    """Least squares of the distances of rows from a loop, of its turning points, and of the drift.

    A loop has seven parameters (7,): ln f, middle Q_mid and range R of Q, compliance C of the rig,
    U_mid, drift D of U, gross slide S (`loop_masing`). It is partial (S = 0), or gross: the contact
    slides as a whole at its ends, and R = 2 f P.
    """

    rows: MeasuredRows
    curve: MemoryCurve
    sigma: RowNoise

    @property
    def parameter_sizes(self) -> Array:
        """Typical sizes of the parameters (7,)."""
        return self.rows.parameter_sizes

    def residuals(self, parameters: Array) -> tuple[Array, Array]:
        """Residuals of a loop of Q over U from measured rows, each over its standard deviation,
        (n + 3,): distances of the n rows, misfit of both turning points, and the drift. With them
        their derivatives by the loop's seven `parameters` (7,), (n + 3, 7).

        The parameters are ln f, middle and range of Q, compliance C of the rig, origin of U, drift
        of U, gross slide. `DRIFT_RATE` is the index of the drift.

        # notation: f coefficient of friction, Q tangential load, U relative displacement, sigma
        #           standard deviation of the noise
        """
        # signed distances (n,) over sigma, and their derivatives (n, 7)
        distances = distances_from_loop(self.rows, self.curve, parameters, self.sigma)
        misfit_of_turns, derivatives_of_turns = self._misfit_of_turning_points(parameters)
        # a gauge drifts by up to 2 % of the range of U: _SIGMA_OF_DRIFT is 0.0115 of that range
        inverse_sigma_of_drift = 1 / (_SIGMA_OF_DRIFT * float(np.ptp(self.rows.displacement)))
        derivatives_of_drift = np.zeros((1, 7))
        derivatives_of_drift[0, DRIFT_RATE] = inverse_sigma_of_drift
        return (
            np.concatenate(
                [
                    distances.signed_distance,
                    misfit_of_turns,
                    [parameters[DRIFT_RATE] * inverse_sigma_of_drift],
                ]
            ),
            np.concatenate([distances.derivatives, derivatives_of_turns, derivatives_of_drift]),
        )

    def _misfit_of_turning_points(self, parameters: Array) -> tuple[Array, Array]:
        """Misfit of the two turning points of a loop of Q over U to those of the measured rows,
        over its standard error, (2,), the highest first; and its derivatives by the loop's seven
        `parameters`, (2, 7).

        A turning point is where the height U/(range of U) + Q/(range of Q) is largest or least; the
        misfit is the height of the loop minus that of the rows. Q alone does not show where a loop
        turns: it stays constant while the contact slides as a whole.

        # notation: Q tangential load, U relative tangential displacement
        """
        rows = self.rows
        turns_of_rows = (rows.branches.highest_turn, rows.branches.lowest_turn)
        misfit = np.zeros(2)
        derivatives = np.zeros((2, 7))
        # mean_time: mean time of these turning points over that of the record, from -1/2 to 1/2
        for k, (turn_of_rows, sign_of_turn, mean_time) in enumerate(
            zip(turns_of_rows, (1.0, -1.0), rows.mean_times_of_turns, strict=True)
        ):
            height_of_loop, height_gradient = self._height_of_turn(
                parameters, sign_of_turn, mean_time
            )
            # _LEAST_ERROR_OF_TURN: 0.002, since a parabola describes a branch no better
            error_of_height = max(turn_of_rows.standard_error, _LEAST_ERROR_OF_TURN)
            # the branches were found in heights: `load` of their turning points is a height
            misfit[k] = (height_of_loop - turn_of_rows.load) / error_of_height
            derivatives[k] = height_gradient / error_of_height
        return misfit, derivatives

    def _height_of_turn(
        self, parameters: Array, sign_of_turn: float, mean_time: float
    ) -> tuple[float, Array]:
        """Height U/(range of U) + Q/(range of Q) of a turning point of a loop of Q over U, over the
        ranges of the measured rows; and its derivatives by the loop's seven parameters, (7,).

        Parameters
        ----------
        parameters
            (7,) ln f, middle and range of Q, compliance of the rig, origin of U, drift of U, gross
            slide; `MIDDLE`, `ORIGIN` and `DRIFT_RATE` are indices of three of them
        sign_of_turn
            1 for the highest turning point, -1 for the lowest
        mean_time
            mean time of such turning points over that of the record, from -1/2 to 1/2, which gives
            the drift there

        # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
        """
        # the rising branch ends at place 2 (places are a parameter along it); the falling branch is
        # the same, rotated about the middle of the loop
        loop = MasingLoop(self.curve, parameters)
        place_of_turn = np.array([2.0])
        # U and Q there, from the middle of the loop, and their derivatives (1, 7)
        displacement_at_end, load_at_end = loop.points(place_of_turn)
        displacement_gradients, load_gradients = loop.derivatives(place_of_turn)
        displacement_gradient = sign_of_turn * displacement_gradients[0]
        displacement_gradient[ORIGIN] = 1.0
        displacement_gradient[DRIFT_RATE] = mean_time
        load_gradient = sign_of_turn * load_gradients[0]
        load_gradient[MIDDLE] = 1.0
        displacement = (
            sign_of_turn * displacement_at_end[0]
            + parameters[ORIGIN]
            + parameters[DRIFT_RATE] * mean_time
        )
        load = sign_of_turn * load_at_end[0] + parameters[MIDDLE]
        range_of_displacement, range_of_load = self.rows.ranges
        return (
            float(displacement / range_of_displacement + load / range_of_load),
            displacement_gradient / range_of_displacement + load_gradient / range_of_load,
        )

    def sum_of_squares(self, parameters: Array) -> float:
        """Sum of the squared residuals of the loop with these parameters (7,)."""
        residuals, _ = self.residuals(parameters)
        return float(residuals @ residuals)

    def least_squares_fit(
        self,
        start_parameters: Array,
        *,
        is_gross: bool,
        held_parameters: frozenset[int] = frozenset(),
    ) -> _LeastSquaresFit:
        """Fit the seven parameters of a loop of Q over U to measured rows by least squares: ln f,
        middle and range R of Q, compliance C of the rig, origin of U, drift of U, gross slide.
        Returns the least sum of squares, with the parameters (7,) that give it.

        Parameters
        ----------
        start_parameters
            (7,) from which the fit begins
        is_gross
            whether the contact slides as a whole at the ends of the loop: the range of Q then
            follows from f, R = 2 f P, and the slide is fitted
        held_parameters
            indices of further parameters that keep their start value

        # notation: f coefficient of friction, P normal load, Q tangential load, U relative
        #           tangential displacement
        """
        from scipy.optimize import least_squares

        # indices: all but the slide of a partial loop, the range of a gross one, and a stated
        # compliance
        fitted_indices = _fitted_parameters(self.rows, is_gross=is_gross)
        free_indices = np.array([k for k in fitted_indices if k not in held_parameters])
        sizes_of_steps = self.parameter_sizes[free_indices]

        def parameters_at(steps: Array) -> Array:
            """All seven parameters (7,) of a loop: those at `free_indices` are moved by `steps`, in
            units of their typical sizes.
            """
            parameters = start_parameters.copy()
            parameters[free_indices] += steps * sizes_of_steps
            return self._parameters_in_bounds(parameters, is_gross=is_gross)

        # scipy calls for residuals and for derivatives separately: both are cached for the latest
        # steps
        cached_residuals: dict[bytes, tuple[Array, Array]] = {}

        def residuals_and_derivatives(steps: Array) -> tuple[Array, Array]:
            """Residuals of a loop from measured rows over sigma (m,), and their derivatives by
            `steps` of the free parameters, (m, free parameters), which stand at `free_indices`.

            # notation: sigma standard deviation of the noise
            """
            steps_as_bytes = steps.tobytes()
            if steps_as_bytes not in cached_residuals:
                residuals, derivatives = self._residuals_of_kind(
                    parameters_at(steps), is_gross=is_gross
                )
                cached_residuals.clear()
                cached_residuals[steps_as_bytes] = (
                    residuals,
                    derivatives[:, free_indices] * sizes_of_steps,
                )
            return cached_residuals[steps_as_bytes]

        minimum = least_squares(
            lambda steps: residuals_and_derivatives(steps)[0],
            np.zeros(len(free_indices)),
            jac=lambda steps: residuals_and_derivatives(steps)[1],
            method="lm",
            xtol=1e-8,
            ftol=1e-10,
            max_nfev=60,
        )
        # scipy's cost is half the sum of squares
        return _LeastSquaresFit(2 * float(minimum.cost), parameters_at(minimum.x))

    def _parameters_in_bounds(self, parameters: Array, *, is_gross: bool) -> Array:
        """The parameters (7,) of a loop of Q over U with ln f between -30 and 30. The range R of Q
        of a gross loop, which slides as a whole at its ends, follows from f: R = 2 f P. `LOG_F` and
        `RANGE` are the indices of ln f and of R; `parameters` is changed.

        # notation: f coefficient of friction, P normal load, Q tangential load, U relative
        #           tangential displacement
        """
        parameters[LOG_F] = min(max(parameters[LOG_F], -30.0), 30.0)
        if is_gross:
            # sliding_friction_per_load: f at which the contact just slides as a whole, over the
            # range of Q
            parameters[RANGE] = math.exp(parameters[LOG_F]) / self.curve.sliding_friction_per_load
        return parameters

    def _residuals_of_kind(self, parameters: Array, *, is_gross: bool) -> tuple[Array, Array]:
        """Residuals of a partial or a gross loop from the measured rows over sigma, (n + 3,), and
        their derivatives by its seven `parameters`, (n + 3, 7). The range R of Q of a gross loop
        follows from ln f, R = 2 f P: the derivative by ln f then contains that by R.

        # notation: f coefficient of friction, P normal load, Q tangential load, sigma standard
        #           deviation of the noise
        """
        residuals, derivatives = self.residuals(parameters)
        if is_gross:
            derivatives[:, LOG_F] += parameters[RANGE] * derivatives[:, RANGE]
        return residuals, derivatives

    def start_parameters(self, log_friction: float, slide_fraction: float) -> Array:
        """Parameters (7,) of a loop of Q over U from which a fit to measured rows begins: ln f,
        middle and range of Q, compliance C of the rig, origin of U, drift of U (0), gross slide.

        C is such that theory's U plus C Q ranges as far as U of the rows. f of a gross loop, in
        which the contact slides as a whole, follows from the range of Q: it is 2 f P.

        Parameters
        ----------
        log_friction
            ln f of a partial loop; not used in a gross one
        slide_fraction
            range of U that is gross slide, over the whole range of U; 0 for a partial loop

        # notation: f coefficient of friction, P normal load, Q tangential load, R range of Q, U
        #           relative tangential displacement
        """
        rows = self.rows
        high_load, low_load = np.quantile(rows.load, [0.98, 0.02])
        range_of_load = float(high_load - low_load)
        if slide_fraction > 0:
            # sliding_friction_per_load: f at which the contact just slides as a whole, over the
            # range of Q
            log_friction = math.log(self.curve.sliding_friction_per_load * range_of_load)
        friction = math.exp(log_friction)
        range_of_displacement = float(np.ptp(np.quantile(rows.displacement, [0.01, 0.99])))
        # memory curve v, `self.curve.value`: U of theory ranges over 2 f v(R/2f) while Q ranges
        # over R
        range_of_theory_displacement = (
            2 * friction * float(self.curve.value(np.array(range_of_load / 2 / friction)))
        )
        # the stated C, or None
        compliance = rows.compliance
        if compliance is None:
            compliance = (
                (1 - slide_fraction) * range_of_displacement - range_of_theory_displacement
            ) / range_of_load
        middle_of_displacement = float(np.mean(np.quantile(rows.displacement, [0.02, 0.98])))
        return np.array(
            [
                log_friction,
                (high_load + low_load) / 2,
                range_of_load,
                compliance,
                middle_of_displacement,
                0.0,
                slide_fraction * range_of_displacement,
            ]
        )

    def best_fits(self) -> _FitsOfBothKinds:
        """The best loop for measured rows of Q over U that slips partially, and the best gross one,
        where the contact slides as a whole at its ends: each with its least sum of squares and its
        seven parameters.

        The sum of squares is taken at 24 trials of f for a partial loop, and at 5 trials of the
        slide for a gross one.

        # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
        """
        # start parameters (7,) of each trial: ln f and fraction of the range of U that is slide
        partial_starts = [
            self.start_parameters(log_friction, 0.0)
            for log_friction in self._trial_log_frictions().tolist()
        ]
        gross_starts = [self.start_parameters(0.0, fraction) for fraction in _SLIDE_FRACTIONS]
        return _FitsOfBothKinds(
            self._best_fit_from(partial_starts, is_gross=False),
            self._best_fit_from(gross_starts, is_gross=True),
        )

    def _trial_log_frictions(self) -> Array:
        """ln f of the 24 trials of a partial loop, ascending: from 1.002 to 40 times the f at which
        the contact just slides as a whole under the range of Q, closer and closer towards that f.

        # notation: f coefficient of friction, Q tangential load
        """
        # nearly the largest and the least Q, without the rows that noise takes farthest
        high_load, low_load = np.quantile(self.rows.load, [0.98, 0.02])
        log_least_friction = math.log(
            self.curve.sliding_friction_per_load * float(high_load - low_load)
        )
        roots = np.linspace(
            math.sqrt(_LEAST_LOG_RATIO), math.sqrt(math.log(_LARGEST_TRIAL_RATIO)), _N_TRIALS
        )
        return np.asarray(log_least_friction + roots**2)

    def _best_fit_from(self, starts: list[Array], *, is_gross: bool) -> _LeastSquaresFit:
        """The best of two fits of a loop to the measured rows, partial or gross. They begin from
        the two lowest local minima of the sum of squares among `starts`, parameters (7,) of trials
        in the order of their f or slide.
        """
        sums_of_squares = np.array(
            [self.sum_of_squares(start_parameters) for start_parameters in starts]
        )
        # trials with no smaller sum on either side; the walls are infinite sums beyond the ends
        sums_with_walls = np.concatenate([[math.inf], sums_of_squares, [math.inf]])
        minimum_indices = np.flatnonzero(
            (sums_of_squares <= sums_with_walls[:-2]) & (sums_of_squares <= sums_with_walls[2:])
        )
        order = np.argsort(sums_of_squares[minimum_indices])
        lowest_indices = minimum_indices[order][:_N_MINIMA]
        fits = [self._fit_near(starts[k], is_gross=is_gross) for k in lowest_indices.tolist()]
        return min(fits, key=lambda fit: fit.sum_of_squares)

    def fits_near(self, fits: _FitsOfBothKinds) -> _FitsOfBothKinds:
        """The best partial and the best gross loop, sought from `fits` on."""
        return _FitsOfBothKinds(
            self._fit_near(fits.partial_fit.parameters, is_gross=False),
            self._fit_near(fits.gross_fit.parameters, is_gross=True),
        )

    def _fit_near(self, start_parameters: Array, *, is_gross: bool) -> _LeastSquaresFit:
        """The best loop of one kind for measured rows, sought from `start_parameters` (7,) on:
        partial, or gross (the contact slides as a whole at its ends).

        The best partial loop may slide as a whole, or the best gross one may have a negative slide.
        Then the best loop at the limit between both kinds is returned: gross with a slide of 0.
        `LOG_F`, `RANGE` and `SLIDE` are indices of ln f, range of Q and slide.

        # notation: f coefficient of friction, Q tangential load
        """
        fit = self.least_squares_fit(start_parameters, is_gross=is_gross)
        if not is_gross and self._is_sliding_as_whole(fit.parameters):
            parameters = fit.parameters.copy()
            # just sliding: f is this constant of the scene times the range of Q
            parameters[LOG_F] = math.log(self.curve.sliding_friction_per_load * parameters[RANGE])
            return self._fit_without_slide(parameters)
        if is_gross and fit.parameters[SLIDE] < 0:
            return self._fit_without_slide(fit.parameters)
        return fit

    def _fit_without_slide(
        self, start_parameters: Array, held_parameters: frozenset[int] = frozenset()
    ) -> _LeastSquaresFit:
        """The best loop at the limit between partial slip and gross sliding, for measured rows:
        gross with a slide of 0, sought from parameters (7,) on. `held_parameters` are indices of
        those that keep their start value; `SLIDE` is that of the slide.
        """
        parameters = start_parameters.copy()
        parameters[SLIDE] = 0.0
        return self.least_squares_fit(
            parameters, is_gross=True, held_parameters=held_parameters | {SLIDE}
        )

    def _is_sliding_as_whole(self, parameters: Array) -> bool:
        """Whether the contact of a partial loop with parameters (7,) would slide as a whole."""
        return bool(
            math.exp(parameters[LOG_F]) < self.curve.sliding_friction_per_load * parameters[RANGE]
        )

    def fit_at_friction(
        self, log_friction: float, start_parameters: Array, *, is_gross: bool
    ) -> _LeastSquaresFit:
        """The best loop of one kind for measured rows at a given coefficient of friction f,
        `log_friction` = ln f: gross (the contact slides as a whole at its ends), or partial. It is
        sought from `start_parameters` (7,) on: ln f, middle and range of Q, compliance of the rig,
        origin and drift of U, slide.

        Where the slide of a gross loop would be negative it is held at 0. The sum of squares of a
        partial loop is infinite where its contact would slide as a whole. `LOG_F` and `SLIDE` are
        indices of ln f and of the slide.

        # notation: Q tangential load, U relative tangential displacement
        """
        index_of_friction = frozenset([LOG_F])
        parameters = start_parameters.copy()
        parameters[LOG_F] = log_friction
        fit = self.least_squares_fit(
            parameters, is_gross=is_gross, held_parameters=index_of_friction
        )
        if is_gross and fit.parameters[SLIDE] < 0:
            return self._fit_without_slide(fit.parameters, held_parameters=index_of_friction)
        if not is_gross and self._is_sliding_as_whole(fit.parameters):
            return _LeastSquaresFit(math.inf, fit.parameters)
        return fit

    def interval_end(
        self,
        fits: _FitsOfBothKinds,
        direction: float,
        admitted_rise_of_better_kind: float,
        first_step: float,
    ) -> Array | None:
        """One end of the 95 % interval of the coefficient of friction f of a measured loop: the
        seven parameters (7,) of the fitted loop at the f where the least sum of squares exceeds
        that of the better fit by `admitted_rise_of_better_kind`. None where it never does. The
        squares are distances of the rows from a loop.

        Parameters
        ----------
        fits
            the best partial loop, and the best gross one (the contact slides as a whole at its
            turning points). Loops of the worse kind are admitted with a larger rise, since the
            rows chose between the two kinds
        direction
            1 for the upper end, -1 for the lower one
        admitted_rise_of_better_kind
            rise of the least sum of squares up to which loops of the better kind are admitted
        first_step
            first step in ln f

        # notation: f coefficient of friction
        """
        is_gross_better = fits.is_gross_better
        # of each kind (is it gross?) the latest fit, from which the next one is sought
        parameters_by_kind = {False: fits.partial_fit.parameters, True: fits.gross_fit.parameters}
        is_nearest_kind_gross = is_gross_better

        def root_of_relative_rise(log_friction: float) -> float:
            """Square root of the rise of the least sum of squares over its admitted rise, at ln f =
            `log_friction`: 0 at the best f, 1 at the end of the interval, nearly linear in between.
            The loop is of that kind, partial or gross, for which it is less.

            The squares are distances of measured rows from a loop. `fits` are the best fit of
            either kind, `admitted_rise_of_better_kind` is the admitted rise for the better kind.
            `parameters_by_kind` holds the latest parameters (7,) of each kind: gross (True), or
            partial.

            # notation: f coefficient of friction
            """
            nonlocal is_nearest_kind_gross
            least_relative_rise = math.inf
            for is_gross in (is_nearest_kind_gross, not is_nearest_kind_gross):
                fit = self.fit_at_friction(
                    log_friction, parameters_by_kind[is_gross], is_gross=is_gross
                )
                if math.isfinite(fit.sum_of_squares):
                    parameters_by_kind[is_gross] = fit.parameters
                admitted_rise = admitted_rise_of_better_kind
                if is_gross != is_gross_better:
                    # chi squared of three degrees over that of one: 2.03
                    admitted_rise = _EXCESS_OF_OTHER_KIND * admitted_rise_of_better_kind
                rise = max(fit.sum_of_squares - fits.better_fit.sum_of_squares, 0.0)
                relative_rise = rise / admitted_rise
                if relative_rise < least_relative_rise:
                    least_relative_rise = relative_rise
                    is_nearest_kind_gross = is_gross
                if least_relative_rise <= 1:  # within the interval, whatever the other kind gives
                    break
            return math.sqrt(least_relative_rise)

        # ln f at which the root reaches 1, sought from the best ln f on; None where it never does
        log_friction_at_end = where_function_reaches_one(
            root_of_relative_rise, float(fits.better_fit.parameters[LOG_F]), direction, first_step
        )
        if log_friction_at_end is None:
            return None
        fit_at_end = self.fit_at_friction(
            log_friction_at_end,
            parameters_by_kind[is_nearest_kind_gross],
            is_gross=is_nearest_kind_gross,
        )
        return fit_at_end.parameters


def where_function_reaches_one(
    function: Callable[[float], float], x_at_zero: float, direction: float, first_step: float
) -> float | None:
    """The x at which a function that grows from 0 at `x_at_zero` reaches 1, to 1 % of the distance
    between both: by steps outwards, then by false position between the last two trial x.

    None where it stays below 1 as far as ln 60 from `x_at_zero` (x is ln f: 60 times as much
    friction), or where it still does after 30 steps outwards.

    Parameters
    ----------
    x_at_zero
        x at which the function is 0
    direction
        1 for x above `x_at_zero`, -1 below
    first_step
        first distance tried

    Examples
    --------
    >>> end = where_function_reaches_one(lambda x: 2 * abs(x), 0.0, 1.0, 0.3)
    >>> abs(end - 0.5) < 0.005
    True

    # notation: f coefficient of friction
    """
    # distances in x from `x_at_zero`: the last one with a value below 1, the first one above it
    distance_within = 0.0
    value_within = 0.0
    step = first_step

    # steps outwards, until the function is above 1
    for _ in range(_MOST_STEPS):
        distance_beyond = distance_within + min(step, 0.5)
        value_beyond = function(x_at_zero + direction * distance_beyond)
        if value_beyond > 1:
            break
        if distance_beyond > math.log(_LARGEST_FRICTION_RATIO):
            return None
        step = 1.3 * distance_beyond * (1 / max(value_beyond, 0.1)) - distance_beyond
        distance_within = distance_beyond
        value_within = value_beyond
    else:
        return None

    # false position between both distances, at most 12 times
    for _ in range(_MOST_NARROWINGS):
        if distance_beyond - distance_within < 0.01 * distance_beyond:
            break
        fraction_by_secant = (1 - value_within) / (min(value_beyond, 1e6) - value_within)
        fraction = float(np.clip(fraction_by_secant, 0.1, 0.9))
        distance_between = distance_within + fraction * (distance_beyond - distance_within)
        value_between = function(x_at_zero + direction * distance_between)
        if abs(value_between - 1) < 0.01:
            return x_at_zero + direction * distance_between
        if value_between > 1:
            distance_beyond = distance_between
            value_beyond = value_between
        else:
            distance_within = distance_between
            value_within = value_between
    return x_at_zero + direction * distance_beyond


def _likeliest_noise(
    distances: Distances,
    sigma: RowNoise,
    least_noise: RowNoise,
    degrees_of_freedom: int,
    log_noise_ratio: float,
    scatter_of_log_ratio: float,
) -> RowNoise:
    """Standard deviations of the noise of U and of Q in measured rows: those that make the
    distances of the rows from a fitted loop most likely, and the ratio of the two as well. The
    ratio scatters about the one that neighbouring rows show.

    Parameters
    ----------
    distances
        of the n rows from the loop: `signed_distance` (n,), over the given `sigma`, and
        `unit_normal` (n, 2) of the loop at the nearest point, in sigma of U and of Q
    sigma
        standard deviations of U and of Q so far
    least_noise
        least standard deviations of U and Q, by the digits of the rows
    degrees_of_freedom
        number of rows minus number of fitted parameters
    log_noise_ratio, scatter_of_log_ratio
        ln(sigma of U/sigma of Q) that neighbouring rows show, and its standard deviation

    # notation: Q tangential load, U relative tangential displacement
    """
    from scipy.optimize import minimize

    # log_factors: ln of the factors by which sigma of U and sigma of Q change
    expected_log_ratio = log_noise_ratio - math.log(sigma.of_displacement / sigma.of_load)
    # a fitted loop lies nearer to the rows than the true one
    squared_distances = (
        distances.signed_distance**2 * len(distances.signed_distance) / degrees_of_freedom
    )
    squared_normals = distances.unit_normal**2

    def minus_log_likelihood(log_factors: Array) -> float:
        """Twice the negative logarithm of the likelihood, but for a constant, of the distances and
        of the ratio, with sigma times the exponentials of `log_factors` (2,) for U and Q.
        """
        # of each distance, in squares of the sigma so far
        variance = squared_normals @ np.exp(2 * log_factors)
        error_of_log_ratio = log_factors[0] - log_factors[1] - expected_log_ratio
        term_of_ratio = float(error_of_log_ratio**2) / scatter_of_log_ratio**2
        return float(np.sum(squared_distances / variance + np.log(variance))) + term_of_ratio

    log_of_common_factor = math.log(max(math.sqrt(float(np.mean(squared_distances))), 1e-12))
    least_log_factors = np.log(np.array(least_noise) / np.array(sigma))
    minimum = minimize(
        minus_log_likelihood,
        np.maximum(log_of_common_factor, least_log_factors),
        method="Nelder-Mead",
        bounds=[(float(least_log), math.inf) for least_log in least_log_factors],
        options={"xatol": 1e-3},
    )
    factors = np.exp(np.maximum(minimum.x, least_log_factors))
    return RowNoise(float(factors[0]) * sigma.of_displacement, float(factors[1]) * sigma.of_load)


@dataclass(frozen=True, eq=False)
class BestLoop:
    """The loop that follows rows best, before its interval is sought.

    Attributes
    ----------
    search
        the rows, the memory curve and the noise, with which other loops are fitted
    fits
        the best partial and the best gross loop
    parameters
        (7,) of the better of both
    is_gross
        whether the contact slides as a whole at its ends
    distances
        of the rows from it
    misfit
        correlation of the distances of neighbouring rows, and their systematic part
    degrees_of_freedom
        number of rows minus number of fitted parameters
    """

    search: _Search
    fits: _FitsOfBothKinds
    parameters: Array
    is_gross: bool
    distances: Distances
    misfit: Misfit
    degrees_of_freedom: int

    @property
    def depends_on_last_digits(self) -> bool:
        """Whether f of the best loop hangs on the last digit of Q: the contact slides as a whole,
        and no noise moves the last digit of a plateau of Q.
        """
        error_by_digits = _error_by_digits(self.search.rows, self.search.curve, self.search.sigma)
        return self.is_gross and error_by_digits > 0

    def change_with(self, row_variable: Array) -> ExplainedChange:
        """How the fitted parameters of the loop change with a variable of the rows (n,), such as
        their time: the change that explains most of the distances of the rows from the loop.

        Origin and drift of U are left out: the change of U with time is drift.

        # notation: U relative tangential displacement
        """
        is_varied = np.isin(self._fitted_indices, [ORIGIN, DRIFT_RATE], invert=True)
        variable_from_mean = row_variable - np.mean(row_variable)
        # (n, k) derivatives of the distances by the k fitted parameters
        derivatives = self._derivatives_by_parameters
        added_derivatives = derivatives[:, is_varied] * variable_from_mean[:, None]
        # F test, and values of the parameters' change per unit of the variable
        return explained_change(self.distances.signed_distance, derivatives, added_derivatives)

    def change_of_size_with(self, row_variable: Array) -> ExplainedChange:
        """How U and Q of the loop grow with a variable of the rows (n,), such as their time. The
        two `added_values` of the returned change are the relative growth of U and of Q per unit of
        the variable.
        """
        variable_from_mean = row_variable - np.mean(row_variable)
        # derivatives (n, 2) of the distances by the relative sizes of U and of Q
        added_derivatives = self._derivatives_by_size * variable_from_mean[:, None]
        return explained_change(
            self.distances.signed_distance, self._derivatives_by_parameters, added_derivatives
        )

    def log_friction_change(self, growth: Array, row_variable: Array) -> float:
        """Change of ln f if all rows are made as large as the last ones. U and Q grow by `growth`
        (2,), relative to themselves, per unit of a variable of the rows (n,), such as their time.
        """
        variable_to_end = row_variable - row_variable[-1]
        # derivatives (n, 2) of the distances by the relative sizes of U and of Q
        change_of_distances = self._derivatives_by_size @ growth * variable_to_end
        # (7, m) change of each parameter per unit of each residual; the n rows stand first
        influence = _parameter_changes_by_residuals(self.search, self.parameters, self.is_gross)
        return float(influence[LOG_F, : len(row_variable)] @ change_of_distances)

    def rise_along_slide(self) -> tuple[float, ExplainedChange]:
        """By how much Q of the rows of a gross loop rises while the contact slides as a whole, over
        the range R of Q; with the part of the rows' distances from the loop that such a rise
        explains, and the chance of scatter to explain as much.

        # notation: Q tangential load, sigma standard deviation of the noise
        """
        # (n,) of the rows: 0 to 1 on the rising branch, 1 to 2 on the falling one
        place_on_loop = self.distances.place_on_loop
        share_of_branch = np.mod(place_on_loop, 1.0)  # the second half of a branch is its slide
        share_of_slide = np.clip(2 * share_of_branch - 1, 0.0, 1.0)
        sign_of_branch = np.where(place_on_loop > 1, -1.0, 1.0)
        # a rise of R over the whole slide; RANGE: index of R
        rise_of_load = self.parameters[RANGE] * sign_of_branch * share_of_slide
        # component in Q of the unit normal of the loop, in sigma
        unit_normal_in_load = self.distances.unit_normal[:, 1]
        derivative_by_rise = -unit_normal_in_load * rise_of_load / self.search.sigma.of_load
        # added_values of this change: the rise over R
        change = explained_change(
            self.distances.signed_distance,
            self._derivatives_by_parameters,
            derivative_by_rise[:, None],
        )
        return float(change.added_values[0]), change

    @property
    def _fitted_indices(self) -> list[int]:
        """Indices of the parameters that are fitted."""
        return _fitted_parameters(self.search.rows, is_gross=self.is_gross)

    @property
    def _derivatives_by_parameters(self) -> Array:
        """Derivatives (n, k) of the distances of the rows by the k fitted parameters, over their
        typical sizes.
        """
        derivatives = _scaled_derivatives(
            self.search, self.parameters, self.distances.derivatives, self.is_gross
        )
        return derivatives[:, self._fitted_indices]

    @property
    def _derivatives_by_size(self) -> Array:
        """Derivatives (n, 2) of the distances by the sizes of U and of Q, over themselves."""
        loop = MasingLoop(self.search.curve, self.parameters)
        points_at_rows = np.column_stack(loop.points_at_rows(self.distances.place_on_loop))
        return -self.distances.unit_normal * points_at_rows / np.array(self.search.sigma)


def _misfit_of_loop(distances: Distances, sigma: RowNoise, least_noise: RowNoise) -> Misfit:
    """Whether neighbouring rows lie on the same side of the fitted loop, so that their distances
    are more than scatter: the correlation of neighbours, and the systematic part.

    Neighbours in time and neighbours along the loop, which are of several cycles, are both tried;
    the larger correlation counts. Where the digits of the rows explain the distances nothing is
    systematic.

    Parameters
    ----------
    distances
        of the n rows from the loop: `signed_distance` (n,) over `sigma`; `unit_normal` (n, 2) of
        the loop, in sigma of U and of Q; `place_on_loop` (n,), 0 to 1 on the rising branch and 1 to
        2 on the falling one
    sigma
        standard deviation of the noise of U and of Q
    least_noise
        standard deviations that the digits of the rows leave

    # notation: Q tangential load, U relative tangential displacement
    """
    variance_by_digits = distances.unit_normal**2 @ (np.array(least_noise) / np.array(sigma)) ** 2
    # _LARGEST_MEAN_SQUARE_BY_DIGITS: 1.3 variances of the last digits
    digits_explain_all = float(
        np.mean(distances.signed_distance**2)
    ) < _LARGEST_MEAN_SQUARE_BY_DIGITS * float(np.mean(variance_by_digits))
    # Neighbours on the loop are rounded alike. That is no fault of the model, but they count as
    # fewer rows, and any correlation counts: it is no chance.
    # Else one counts from 3 standard deviations on, which chance exceeds once in 700.
    least_significance = 0.0 if digits_explain_all else MOST_DEVIATIONS_BY_CHANCE
    order_on_loop = np.argsort(distances.place_on_loop, kind="stable")
    # positive inside the loop on both branches: to the right of the rising one, left of the falling
    distance_to_inside = (
        np.where(distances.place_on_loop > 1, -1.0, 1.0) * distances.signed_distance
    )
    # misfit_of: correlation of neighbours in this order of the rows
    misfit_in_time = misfit_of(distances.signed_distance, sigma.of_displacement, least_significance)
    misfit_on_loop = misfit_of(
        distance_to_inside[order_on_loop], sigma.of_displacement, least_significance
    )
    larger_misfit = max(misfit_in_time, misfit_on_loop, key=lambda misfit: misfit.correlation)
    return replace(larger_misfit, systematic_rms=0.0) if digits_explain_all else larger_misfit


def best_loop(rows: MeasuredRows, memory_curve: MemoryCurve) -> BestLoop:
    """Find the loop that fits measured rows of Q over U best, with the noise of U and Q. Loops slip
    partially, or slide as a whole at their ends (gross). Loop and noise are found by turns until
    the noise changes by less than 5 %.

    Parameters
    ----------
    rows
        U, Q, the steps `resolution` that their digits resolve, and the rig's compliance, None
        where it is fitted
    memory_curve
        memory curve of theory at constant P: U over half the change of Q since a turning point,
        from which loops are built (Masing's rule)

    # notation: sigma standard deviation of the noise of U and of Q, P normal load, Q tangential
    #           load, U relative tangential displacement
    """
    least_noise = noise_of_last_digits(rows.displacement, rows.load, rows.resolution)
    # row_noise: what neighbouring rows differ by
    first_sigma = RowNoise(
        max(row_noise(rows.displacement), least_noise.of_displacement),
        max(row_noise(rows.load), least_noise.of_load),
    )
    # of either kind as many parameters are fitted: six, or five beside a stated compliance
    n_fitted = len(_fitted_parameters(rows, is_gross=False))
    degrees_of_freedom = len(rows.displacement) - n_fitted
    search, fits = _fits_with_likeliest_noise(
        _Search(rows, memory_curve, first_sigma), least_noise, degrees_of_freedom
    )
    parameters = fits.better_fit.parameters
    distances = distances_from_loop(rows, memory_curve, parameters, search.sigma)
    return BestLoop(
        search=search,
        fits=fits,
        parameters=parameters,
        is_gross=fits.is_gross_better,
        distances=distances,
        misfit=_misfit_of_loop(distances, search.sigma, least_noise),
        degrees_of_freedom=degrees_of_freedom,
    )


def _fits_with_likeliest_noise(
    search: _Search, least_noise: RowNoise, degrees_of_freedom: int
) -> tuple[_Search, _FitsOfBothKinds]:
    """Fit loops to measured rows and estimate the noise of U and of Q by turns, until the noise
    changes by less than 5 %. Returns the search with the last noise, and the best partial and the
    best gross loop.

    Parameters
    ----------
    search
        fits loops to the rows, with the noise that neighbouring rows show
    least_noise
        standard deviations that the digits of the rows leave
    degrees_of_freedom
        number of rows minus number of fitted parameters

    # notation: Q tangential load, U relative tangential displacement
    """
    log_noise_ratio = math.log(search.sigma.of_displacement / search.sigma.of_load)
    # standard deviation of ln(sigma of U/sigma of Q): 1 to begin with
    scatter_of_log_ratio = _LARGEST_SCATTER_OF_NOISE_RATIO
    fits = search.best_fits()
    for times_reweighted in range(_MOST_REWEIGHTINGS):
        distances = distances_from_loop(
            search.rows, search.curve, fits.better_fit.parameters, search.sigma
        )
        if times_reweighted == 0:
            scatter_of_log_ratio = _scatter_of_noise_ratio(distances)
        new_sigma = _likeliest_noise(
            distances,
            search.sigma,
            least_noise,
            degrees_of_freedom,
            log_noise_ratio,
            scatter_of_log_ratio,
        )
        changes_of_sigma = np.array(new_sigma) / np.array(search.sigma) - 1
        if np.max(np.abs(changes_of_sigma)) < _LARGEST_CHANGE_OF_SAME_NOISE:
            break
        search = replace(search, sigma=new_sigma)
        # With another noise another minimum may be the lowest.
        fits = search.best_fits() if times_reweighted == 0 else search.fits_near(fits)
    return search, fits


def _scatter_of_noise_ratio(distances: Distances) -> float:
    """Standard deviation of ln(sigma of U/sigma of Q) as neighbouring rows show it, at most 1.

    Where the first fit leaves as much as neighbouring rows differ, they differ by noise alone, and
    the ratio that they show is good. It scatters by chance too: by 2.3 over the root of their
    number.

    `distances` are those of the n rows from the loop of the first fit, `signed_distance` (n,) over
    the sigma that neighbouring rows show.

    # notation: Q tangential load, sigma standard deviation of the noise, U relative tangential
    #           displacement
    """
    scatter_by_fit = abs(math.log(max(float(np.std(distances.signed_distance)), 1e-9)))
    least_scatter = _SCATTER_OF_ROW_NOISE / math.sqrt(len(distances.signed_distance))
    return min(max(scatter_by_fit, least_scatter), _LARGEST_SCATTER_OF_NOISE_RATIO)


def fit_with_interval(best_loop: BestLoop, error_of_theory: float) -> MasingFit:
    """The best fit of a measured loop with its 95 % interval of the coefficient of friction f: up
    to where the least sum of squares rises by what the F distribution admits. The interval is
    widened where neighbouring rows lie on the same side of the loop, and by errors that more rows
    would not lessen.

    A loop is gross where the contact slides as a whole at its turning points, else partial. The
    highest f of the interval is None where the rows do not bound f from above: the sum of squares
    never rises so far.

    Parameters
    ----------
    best_loop
        the loop: its parameters, the fits of the best partial and the best gross loop with their
        least sums of squares, and the search, which holds the rows and seeks other fits to them;
        `misfit.widening` is the factor by which the interval of f grows where neighbouring rows
        have correlated distances
    error_of_theory
        error of a fitted f, over f, since theory's memory curve is interpolated between samples

    # notation: P normal load, Q tangential load, sigma standard deviation of the noise
    """
    from scipy.stats import f as f_distribution

    search = best_loop.search
    fits = best_loop.fits
    # of the residuals, each over its sigma: about 1
    variance = max(fits.better_fit.sum_of_squares / best_loop.degrees_of_freedom, 1.0)
    # (7, m) change of each parameter per unit of each residual
    influence = _parameter_changes_by_residuals(search, best_loop.parameters, best_loop.is_gross)
    standard_errors = np.sqrt(variance * np.sum(influence**2, axis=1))
    widening = best_loop.misfit.widening
    admitted_rise = (
        float(f_distribution.ppf(0.95, 1, best_loop.degrees_of_freedom)) * widening**2 * variance
    )
    first_step = float(np.clip(2 * standard_errors[LOG_F] * widening, 1e-9, 0.3))
    friction = math.exp(best_loop.parameters[LOG_F])
    # (7,) of the loop at an end of the interval, found towards smaller f (-1) and larger f (1);
    # None where the sum never rises so far
    parameters_at_lower_end = search.interval_end(fits, -1.0, admitted_rise, first_step)
    parameters_at_upper_end = search.interval_end(fits, 1.0, admitted_rise, first_step)
    # error of f: the plateaus of a gross loop, at Q = f P, are rounded to the last digit of Q
    error_by_digits = 0.0
    if best_loop.is_gross:
        error_by_digits = _error_by_digits(search.rows, search.curve, search.sigma)
    # error of f that more rows would not lessen
    error_beside_scatter = math.hypot(friction * error_of_theory, error_by_digits)
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
        lowest_friction=max(lowest_friction, 0.0),
        highest_friction=highest_friction,
        parameters=best_loop.parameters,
        standard_errors=standard_errors,
        is_gross=best_loop.is_gross,
        sigma=search.sigma,
        distances=best_loop.distances,
        misfit=best_loop.misfit,
        influence=influence,
        degrees_of_freedom=best_loop.degrees_of_freedom,
        error_by_digits=error_by_digits,
        interval_ends=(parameters_at_lower_end, parameters_at_upper_end),
    )


def _error_by_digits(rows: MeasuredRows, memory_curve: MemoryCurve, sigma: RowNoise) -> float:
    """Error of f (95 %) of a gross loop, whose contact slides as a whole, by the last digit of Q:
    all rows of a plateau have the same digits where no noise moves them. 0 where noise does.

    Parameters
    ----------
    rows
        `resolution` holds the steps of U and of Q that the digits of the rows resolve
    memory_curve
        `sliding_friction_per_load` is f at which the contact just slides as a whole, over the range
        of Q
    sigma
        standard deviation of the noise of U and of Q

    # notation: f coefficient of friction, P normal load, Q tangential load, R range of Q, U
    #           relative tangential displacement
    """
    _, step_of_load = rows.resolution
    # noise beyond the step's own variance, of more than 0.4 of the step, changes digits
    if (
        sigma.of_load**2 - step_of_load**2 / 12
        > (_LEAST_NOISE_THAT_CHANGES_DIGITS * step_of_load) ** 2
    ):
        return 0.0
    # f = R/(2 P), and R is the difference of two plateaus that are rounded alike.
    # _SHARE_OF_STEP: a plateau lies within 0.475 of a step in 95 %
    return 2 * _SHARE_OF_STEP * step_of_load * memory_curve.sliding_friction_per_load


def _parameter_changes_by_residuals(search: _Search, parameters: Array, is_gross: bool) -> Array:
    """Change of the seven parameters of a fitted loop per unit of each of the m residuals, in
    linear least squares, (7, m).

    It is 0 for parameters that are not fitted, but for the range R of Q of a gross loop. R follows
    from f there, R = 2 f P, and its change is R times that of ln f.

    Parameters
    ----------
    search
        the measured rows, and the residuals from a loop with their derivatives
    parameters
        (7,) of the loop: ln f, middle and range R of Q, rig compliance, origin and drift of U,
        slide
    is_gross
        whether the contact slides as a whole at the ends of the loop

    # notation: f coefficient of friction, P normal load, Q tangential load, U relative tangential
    #           displacement
    """
    fitted_indices = _fitted_parameters(search.rows, is_gross=is_gross)
    _, derivatives = search.residuals(parameters)
    # derivatives (m, 7) by the parameters over their typical sizes; if gross, R follows ln f
    scaled_derivatives = _scaled_derivatives(search, parameters, derivatives, is_gross)
    pseudo_inverse = np.linalg.pinv(scaled_derivatives[:, fitted_indices])
    typical_sizes = search.parameter_sizes[fitted_indices]
    influence = np.zeros((7, len(derivatives)))
    influence[fitted_indices] = -pseudo_inverse * typical_sizes[:, None]
    # RANGE, LOG_F: indices of R and of ln f
    if is_gross:
        influence[RANGE] = parameters[RANGE] * influence[LOG_F]
    return influence


def _fitted_parameters(rows: MeasuredRows, *, is_gross: bool) -> list[int]:
    """Indices of those of the seven parameters of a loop that are fitted. Not fitted are the slide
    of a partial loop; the range of Q of a gross one, which follows from f; and a compliance of the
    rig that is stated (`rows.compliance`, else None).
    """
    held_indices = {RANGE} if is_gross else {SLIDE}
    if rows.compliance is not None:
        held_indices.add(COMPLIANCE)
    return [k for k in range(7) if k not in held_indices]


def _scaled_derivatives(
    search: _Search, parameters: Array, derivatives: Array, is_gross: bool
) -> Array:
    """Derivatives (n, 7) of residuals by the seven parameters of a loop over their typical sizes,
    from the `derivatives` (n, 7) by the parameters themselves.

    In a gross loop the range R of Q follows from f, R = 2 f P: the derivative by ln f is that along
    both, with dR/d(ln f) = R. `LOG_F` and `RANGE` are indices of ln f and of R.

    # notation: f coefficient of friction, P normal load, Q tangential load
    """
    total_derivatives = derivatives.copy()
    if is_gross:
        total_derivatives[:, LOG_F] += parameters[RANGE] * derivatives[:, RANGE]
    return np.asarray(total_derivatives * search.parameter_sizes)
