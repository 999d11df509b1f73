"""The f of a loop whose Q has more than two turning points in a cycle: rows are placed by their
times.

# notation: C compliance of the rig, f friction coefficient, r factor of the file's Q over the
#           scene's, tau time on the scene's cycle, U relative displacement

Period and phase are those with which the rows of Q fit the scene's Q best. Then C and U0 are found
by linear least squares in U = r U(tau; f/r) + C Q + U0, f by a scan and a bounded search on the sum
of squares, and its interval is where that sum exceeds the least one by what chance gives in 95 %.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from reports.scoring.loop_fitted import FittedLoop, fit_rig, sentences_on_scale
from reports.scoring.loop_rows import MeasuredLoop
from reports.scoring.loop_theory import (
    N_INSTANTS,
    SHARES_OF_CYCLE,
    cycle_loads,
    friction_at_gross_sliding,
    theory_displacement,
)
from scenes import InputError, Scene
from scenes.array_types import Array

_FEWEST_CYCLES = 0.9
_MOST_CYCLES = 2000
# Number of coefficients of friction that are scanned, and the largest over f of gross sliding;
# beyond it a loop is a line.
_N_TRIALS = 60
_LARGEST_FRICTION_RATIO = 40.0
# Rows are of another experiment where their Q differs from the scene's by more than this share of
# its amplitude (root mean square).
_LARGEST_MISFIT = 0.15
# Error of a fitted f by theory at so many instants, straight between, of itself.
_RELATIVE_ERROR_OF_THEORY = 1e-5
# Chance gives so much of the sum of squares over its mean in 95 %: chi squared of one degree.
_CHI_SQUARED = 3.841


def fit_over_time(
    measured_loop: MeasuredLoop, scene: Scene, rig_compliance: float | None
) -> FittedLoop:
    """Fit the friction coefficient f to a measured loop whose tangential load Q has more than two
    turning points a cycle, with the 95 % interval of f.

    Each row is placed on the scene's cycle by its time. Then theory's displacement U for trial
    values of f is compared with U of the rows: f is where the sum of squares is least. The upper
    end of the interval is None where the sum never exceeds its limit.

    Parameters
    ----------
    measured_loop
        U, Q and time of the rows; `resolution`, steps of U and Q that their digits resolve
    rig_compliance
        compliance C of the rig between the places where U is measured [1/stress]; None fits it too

    # notation: P normal load
    """
    # where the rows lie on the scene's cycle. Their Q is `load_scale` times the scene's plus
    # `offset`, at the same P: so f is `load_scale` times the scene's.
    alignment = _required_alignment(measured_loop, scene)
    _, load_of_cycle = cycle_loads(scene)  # Q of the scene
    search = _Search(measured_loop, scene, load_of_cycle, rig_compliance)
    # the least f of the scene: below it the contact slides as a whole at the scene's loads
    sliding_friction = friction_at_gross_sliding(scene)
    trials = search.trial_fits(sliding_friction, alignment)
    best_fit = search.best_fit(trials, alignment)
    friction_of_file = alignment.load_scale * math.exp(best_fit.log_friction)

    # half of the interval on each side, by the scatter of U and by the errors that go with it
    distances_to_ends = _distances_by_scatter(search, trials, best_fit, alignment)
    noise_of_load, friction_changes_by_load_noise = _friction_changes_by_load_noise(
        search, alignment, trials.neighbours_of_best, friction_of_file
    )
    errors_beside_scatter = (
        friction_of_file * _RELATIVE_ERROR_OF_THEORY,
        *friction_changes_by_load_noise,
    )
    lower_half_of_interval, upper_half_of_interval = (
        math.hypot(distance, *errors_beside_scatter) for distance in distances_to_ends
    )
    n_cycles = float(measured_loop.time[-1] / alignment.period)
    _, step_of_load = measured_loop.resolution  # steps that the digits of U and of Q resolve
    return FittedLoop(
        scene=scene,
        friction=friction_of_file,
        lowest_friction=max(
            friction_of_file - lower_half_of_interval, alignment.load_scale * sliding_friction
        ),
        highest_friction=None
        if math.isinf(upper_half_of_interval)
        else friction_of_file + upper_half_of_interval,
        compliance=best_fit.compliance,
        share_of_cycle=alignment.share_of_cycle,
        cycles_passed=measured_loop.time / alignment.period,
        n_cycles=n_cycles,
        load_scale=alignment.load_scale,
        offset=alignment.offset,
        displacement_noise=best_fit.displacement_noise,
        load_noise=max(noise_of_load, step_of_load / math.sqrt(12)),
        sentences=_sentences_on_alignment(alignment, n_cycles),
    )


def _sentences_on_alignment(alignment: _Alignment, n_cycles: float) -> tuple[str, ...]:
    """Sentences for the reader of a fitted loop: how many cycles its rows cover, how closely their
    tangential load Q follows the scene's Q, and that it is larger or smaller where it is.
    """
    return (
        (
            f"The rows cover {n_cycles:.4g} cycles and follow the scene's Q over time to"
            f" {100 * alignment.misfit:.2g} % of its amplitude"
        ),
        *sentences_on_scale(alignment.load_scale),
    )


def _distances_by_scatter(
    search: _Search, trials: _TrialFits, best_fit: _BestFit, alignment: _Alignment
) -> tuple[float, float]:
    """Distances from the fitted friction coefficient f of the file to the lower and to the upper
    end of its 95 % interval, by the scatter of U in the rows. Infinite where no trial value of f on
    that side has a sum of squares beyond the limit.

    Parameters
    ----------
    search
        gives the sum of squared differences of U between theory and rows for any f
    trials
        trial values of ln f of the scene with their sums of squares
    best_fit
        the best ln f of the scene, its sum of squares, and the standard deviation of U's noise
    alignment
        where the rows lie on the scene's cycle; f of the file is its `load_scale` times f of the
        scene
    """
    # 3.841: chi squared of one degree of freedom, 95 %
    largest_sum_of_squares = best_fit.sum_of_squares + _CHI_SQUARED * best_fit.displacement_noise**2
    log_frictions_outside = trials.log_frictions[trials.sums_of_squares > largest_sum_of_squares]
    log_frictions_below = log_frictions_outside[log_frictions_outside < best_fit.log_friction]
    log_frictions_above = log_frictions_outside[log_frictions_outside > best_fit.log_friction]
    friction_of_file = alignment.load_scale * math.exp(best_fit.log_friction)
    log_at_lower_end = search.log_friction_at_limit(
        largest_sum_of_squares, best_fit.log_friction, log_frictions_below, alignment
    )
    log_at_upper_end = search.log_friction_at_limit(
        largest_sum_of_squares, best_fit.log_friction, log_frictions_above, alignment
    )
    distance_to_lower_end = abs(
        alignment.load_scale * math.exp(log_at_lower_end) - friction_of_file
    )
    distance_to_upper_end = abs(
        alignment.load_scale * math.exp(log_at_upper_end) - friction_of_file
    )
    return distance_to_lower_end, distance_to_upper_end


class _TrialFits(NamedTuple):
    """Trial values of the friction coefficient f of a scene, and how well theory's displacement U
    fits the rows of a measured loop with each.

    Attributes
    ----------
    log_frictions
        (k,) ln f, ascending
    sums_of_squares
        (k,) sums of squared differences of U between theory and rows [length^2]
    """

    log_frictions: Array
    sums_of_squares: Array

    @property
    def best_log_friction(self) -> float:
        """ln f of the trial with the least sum of squares."""
        return float(self.log_frictions[np.argmin(self.sums_of_squares)])

    @property
    def neighbours_of_best(self) -> tuple[float, float]:
        """ln f of the trials beside the best one; the best one itself where it is an end."""
        index_of_best = int(np.argmin(self.sums_of_squares))
        last_index = len(self.log_frictions) - 1
        return (
            float(self.log_frictions[max(index_of_best - 1, 0)]),
            float(self.log_frictions[min(index_of_best + 1, last_index)]),
        )


class _BestFit(NamedTuple):
    """Theory's loop that fits the rows of a measured one best.

    Attributes
    ----------
    log_friction
        ln of the scene's friction coefficient
    sum_of_squares
        of the differences of displacement between theory and rows [length^2]
    compliance
        of the rig [1/stress]
    displacement_noise
        standard deviation of these differences [length], at least that of the last digits
    """

    log_friction: float
    sum_of_squares: float
    compliance: float
    displacement_noise: float


@dataclass(frozen=True, eq=False)
class _Search:
    """How far U of the rows is from theory's U(tau; f), as a function of f.

    Attributes
    ----------
    load_of_cycle
        Q of the scene at the instants `SHARES_OF_CYCLE` of its cycle
    rig_compliance
        C [1/stress]; None fits it for each f
    """

    loop: MeasuredLoop
    scene: Scene
    load_of_cycle: Array
    rig_compliance: float | None

    def rig_fit(self, log_friction: float, alignment: _Alignment) -> tuple[float, float, float]:
        """Fit a rig to theory's loop of Q over U and the rows of a measured one: U = r U_theory + C
        r Q + U0, with Q of the scene. Returns the sum of squared residuals of U [length^2], the
        rig's compliance C [1/stress] and origin U0 [length].

        Parameters
        ----------
        log_friction
            ln of the scene's friction coefficient f
        alignment
            `share_of_cycle` (n,) that is over at each row, and `load_scale` r, the file's Q over
            the scene's

        # notation: Q tangential load, U relative tangential displacement
        """
        displacement = theory_displacement(self.scene, math.exp(log_friction))
        load = alignment.load_scale * self.load_of_cycle
        return fit_rig(
            self.loop,
            displacement,
            alignment.share_of_cycle,
            load,
            alignment.load_scale,
            self.rig_compliance,
        )

    def sum_of_squares(self, log_friction: float, alignment: _Alignment) -> float:
        """Sum of squared residuals of U of the rows with this ln f of the scene [length^2]."""
        return self.rig_fit(log_friction, alignment)[0]

    def trial_fits(self, sliding_friction: float, alignment: _Alignment) -> _TrialFits:
        """Sums of squares for 60 trial values of f of the scene, at even steps of ln f. They go
        from just above `sliding_friction`, at which the contact just slides as a whole, to 40 times
        as much.
        """
        log_frictions = np.log(sliding_friction) + np.linspace(
            1e-6, math.log(_LARGEST_FRICTION_RATIO), _N_TRIALS
        )
        sums_of_squares = [
            self.sum_of_squares(log_friction, alignment) for log_friction in log_frictions.tolist()
        ]
        return _TrialFits(log_frictions, np.array(sums_of_squares))

    def best_fit(self, trials: _TrialFits, alignment: _Alignment) -> _BestFit:
        """The fit to the rows of a measured loop with the least sum of squares: of a bounded search
        between the neighbours of the best trial, or this trial itself.

        Its `displacement_noise` is the standard deviation of the residuals of U, at least what the
        digits of the rows leave. `rig_compliance` is C where it is stated, None where it is fitted.

        # notation: C compliance of the rig, f friction coefficient, U relative tangential
        #           displacement, U0 its origin
        """
        log_friction = min(
            self.best_log_friction(trials.neighbours_of_best, alignment),
            trials.best_log_friction,
            key=lambda log_trial: self.sum_of_squares(log_trial, alignment),
        )
        sum_of_squares, compliance, _ = self.rig_fit(log_friction, alignment)
        # f and U0 are fitted, and C
        n_fitted = 2 if self.rig_compliance is not None else 3
        degrees_of_freedom = len(self.loop.time) - n_fitted
        noise = max(
            math.sqrt(sum_of_squares / degrees_of_freedom), self.loop.resolution[0] / math.sqrt(12)
        )
        return _BestFit(log_friction, sum_of_squares, compliance, noise)

    def best_log_friction(
        self, log_friction_bounds: tuple[float, float], alignment: _Alignment
    ) -> float:
        """ln of the scene's friction coefficient f, between two bounds, at which the sum of squared
        differences of U (displacement) between theory and measured rows is least. `alignment`
        states where the rows lie on the scene's cycle.
        """
        from scipy.optimize import minimize_scalar

        minimum = minimize_scalar(
            lambda log_friction: self.sum_of_squares(log_friction, alignment),
            bounds=log_friction_bounds,
            method="bounded",
            options={"xatol": 1e-7},
        )
        return float(minimum.x)

    def log_friction_at_limit(
        self, limit: float, best_log_friction: float, trials: Array, alignment: _Alignment
    ) -> float:
        """ln of the scene's friction coefficient f at which the sum of squared differences of U
        between theory and measured rows reaches `limit`: between the best ln f and the nearest of
        `trials` (k,). The sum exceeds the limit at all of these, on one side of the best one.
        Infinite without any trial.

        `alignment` places the rows on the scene's cycle, `share_of_cycle` (n,), and holds the scale
        of their Q over the scene's.

        # notation: Q tangential load, U relative tangential displacement
        """
        from scipy.optimize import brentq

        if not len(trials):
            return math.inf
        nearest_trial = trials[np.argmin(np.abs(trials - best_log_friction))]

        def excess(log_friction: float) -> float:
            """Sum of squares minus the limit."""
            return self.sum_of_squares(log_friction, alignment) - limit

        return float(brentq(excess, best_log_friction, nearest_trial, xtol=1e-7))


class _Alignment(NamedTuple):
    """Where the rows lie on the scene's cycle.

    Attributes
    ----------
    share_of_cycle
        (n,) share of the cycle that is over at each row, 0 to 1
    load_scale, offset
        r and Q0 with which the file's Q is r Q + Q0 of the scene
    period
        of the cycle, in the file's unit of time
    misfit
        root mean square of the file's Q − (r Q + Q0), over the amplitude of r Q
    """

    share_of_cycle: Array
    load_scale: float
    offset: float
    period: float
    misfit: float


def _required_alignment(measured_loop: MeasuredLoop, scene: Scene) -> _Alignment:
    """Find where on the scene's cycle each row of a measured loop lies, by its time, and the file's
    period, scale and offset of Q: those with which the scene's Q fits that of the rows best.

    Raises
    ------
    InputError
        For less than 0.9 of a cycle, and for rows whose Q differs from the scene's by more than 15
        % of its amplitude (`misfit`, root mean square).

    # notation: Q tangential load
    """
    _, load_of_cycle = cycle_loads(scene)
    # Where Q goes straight between its turning points, rows of one cycle also fit half of a cycle
    # that is twice as large. So trial periods of which the rows cover 0.9 and more come first.
    alignment = _best_alignment(measured_loop, load_of_cycle, _FEWEST_CYCLES)
    if alignment.misfit > _LARGEST_MISFIT:
        alignment = _best_alignment(measured_loop, load_of_cycle)
    n_cycles = measured_loop.time[-1] / alignment.period
    if alignment.misfit > _LARGEST_MISFIT:
        raise InputError(
            f"{measured_loop.source}: its Q follows that of {scene.name} to"
            f" {100 * alignment.misfit:.0f} % of its amplitude only (limit"
            f" {100 * _LARGEST_MISFIT:.0f} %): give a column time, whole cycles, and a scene with"
            " this form of Q"
        )
    if n_cycles < _FEWEST_CYCLES:
        raise InputError(
            f"{measured_loop.source}: its rows cover {n_cycles:.2g} of a cycle: a loop needs a"
            " whole one"
        )
    return alignment


def _best_alignment(
    measured_loop: MeasuredLoop, load_of_cycle: Array, least_cycles: float = 0.0
) -> _Alignment:
    """Find where the rows of a measured loop lie on the scene's cycle: period, phase, scale and
    offset at which Q of this cycle follows Q of the rows best.

    Trial periods come from the spectrum of the file's Q; each is tried at 24 phases, and the best
    trial is refined.

    Parameters
    ----------
    load_of_cycle
        (n_instants,) Q of the scene at the instants `SHARES_OF_CYCLE` of its cycle
    least_cycles
        periods of which the rows cover fewer are left out, as long as others remain

    Raises
    ------
    InputError
        Where Q of the scene stands still.

    # notation: Q tangential load
    """
    if not np.ptp(load_of_cycle) > 0:
        raise InputError("the scene's Q stands still: there is no loop")
    amplitude = float(np.ptp(load_of_cycle) / 2)

    def misfit_as_force(frequency_and_phase: tuple[float, float] | Array) -> float:
        """Root mean square of Q of the rows minus the best fit of the scene's Q."""
        frequency, phase = frequency_and_phase
        return _alignment_at(measured_loop, load_of_cycle, frequency, phase).misfit

    # frequencies of the cycle, and that at which the spectrum of Q is highest
    frequencies, peak_frequency = _trial_frequencies(measured_loop, least_cycles)
    trials = [(frequency, phase) for frequency in frequencies for phase in np.arange(24) / 24]
    best_trial = min(trials, key=misfit_as_force)
    frequency, phase = _refined_frequency_and_phase(
        misfit_as_force, best_trial, peak_frequency, measured_loop.time[-1], 1e-12 * amplitude
    )
    alignment = _alignment_at(measured_loop, load_of_cycle, frequency, phase)
    # from a force per thickness to a share of the amplitude of Q
    return alignment._replace(misfit=alignment.misfit / (abs(alignment.load_scale) * amplitude))


def _alignment_at(
    measured_loop: MeasuredLoop, load_of_cycle: Array, frequency: float, phase: float
) -> _Alignment:
    """Where the rows of a measured loop lie on the scene's cycle, for a given frequency of the
    cycle and its phase (share of a cycle at time 0). Scale and offset of Q are those that fit the
    measured Q best. `load_of_cycle` is Q of the scene at the shares of its cycle,
    `SHARES_OF_CYCLE`; `measured_loop` holds time and Q of the n rows.

    The misfit is a force per thickness here, not yet over the amplitude: the root mean square of
    the measured Q minus this fit. Where the scale is not positive, ten times the range of Q is
    added to it, so that another alignment is taken.

    # notation: Q tangential load
    """
    n_rows = len(measured_loop.load)
    share_of_cycle = np.mod(frequency * measured_loop.time + phase, 1.0)
    scene_load = np.interp(share_of_cycle, SHARES_OF_CYCLE, load_of_cycle)
    columns = np.column_stack([scene_load, np.ones(n_rows)])
    load_scale, offset = np.linalg.lstsq(columns, measured_loop.load, rcond=None)[0].tolist()
    residuals = measured_loop.load - load_scale * scene_load - offset
    misfit = float(np.sqrt(residuals @ residuals / n_rows))
    # A negative scale fits a sine as well as a positive one does half a cycle later: only the
    # positive one counts.
    if load_scale <= 0:
        misfit += 10 * float(np.ptp(measured_loop.load))
    return _Alignment(share_of_cycle, load_scale, offset, float(1 / frequency), misfit)


def _refined_frequency_and_phase(
    misfit: Callable[[tuple[float, float] | Array], float],
    best_trial: tuple[float, float],
    peak_frequency: float,
    last_time: float,
    misfit_tolerance: float,
) -> tuple[float, float]:
    """Frequency of the cycle and its phase (share of a cycle at time 0) with the least misfit
    between Q of measured rows and Q of the scene, near those of the best trial. The method is that
    of Nelder and Mead.

    Parameters
    ----------
    misfit
        (frequency, phase) -> root mean square difference of Q [force per thickness]
    best_trial
        frequency and phase to begin with
    peak_frequency
        frequency at which the spectrum of the measured Q is highest: the scale of the steps
    last_time
        time of the last row; the first one is at 0
    misfit_tolerance
        change of the misfit below which the search ends

    # notation: Q tangential load
    """
    from scipy.optimize import minimize

    # This first step of the search moves the last row by a tenth of a cycle; in a record shorter
    # than a cycle, by less.
    frequency_step = 0.3 / max(last_time * peak_frequency, 1.0) * peak_frequency * 0.3
    simplex_steps = np.array([[0.0, 0.0], [frequency_step, 0.0], [0.0, 0.02]])
    minimum = minimize(
        misfit,
        best_trial,
        method="Nelder-Mead",
        options={
            "initial_simplex": np.array(best_trial) + simplex_steps,
            "xatol": 1e-9 * peak_frequency,
            "fatol": misfit_tolerance,
            "maxiter": 800,
        },
    )
    frequency, phase = minimum.x
    return frequency, phase


def _trial_frequencies(
    measured_loop: MeasuredLoop, least_cycles: float
) -> tuple[list[float], float]:
    """Frequencies of the cycle to try [cycles per unit of time], from the spectrum of Q of the rows
    of a measured loop; and the frequency at which this spectrum is highest.

    Those by which the rows cover fewer than `least_cycles` are left out, as long as others remain.
    They are the frequency of the peak, its half and its third, and some 6 % beside each.

    # notation: Q tangential load
    """
    # loop.time begins at 0
    even_times = np.linspace(0.0, measured_loop.time[-1], min(len(measured_loop.load), 4096))
    even_loads = np.interp(even_times, measured_loop.time, measured_loop.load)
    load_from_mean = even_loads - even_loads.mean()
    n_times = len(even_times)
    spectrum = np.abs(np.fft.rfft(load_from_mean * np.hanning(n_times), 8 * n_times))
    record_length = measured_loop.time[-1] * n_times / (n_times - 1)
    # Eight values of the spectrum belong to one cycle in the record; the first four to the mean.
    most_cycles = min(_MOST_CYCLES, n_times // 4)
    cycles_in_record = float(np.argmax(spectrum[4 : 8 * most_cycles]) + 4) / 8
    peak_frequency = max(cycles_in_record, 0.5) / record_length
    # The spectrum may be highest at the second or third harmonic of the cycle.
    # factors: 6 % beside each
    frequencies = [
        peak_frequency / harmonic * factor for harmonic in (1, 2, 3) for factor in (0.94, 1.0, 1.06)
    ]
    if peak_frequency * record_length < 3:  # a spectrum of a few cycles has no sharp maximum
        frequencies += (np.arange(0.9, 3.0, 0.05) / record_length).tolist()
    frequencies_of_enough_cycles = [
        frequency for frequency in frequencies if frequency * measured_loop.time[-1] >= least_cycles
    ]
    return frequencies_of_enough_cycles or frequencies, peak_frequency


def _friction_changes_by_load_noise(
    search: _Search,
    alignment: _Alignment,
    log_friction_bounds: tuple[float, float],
    friction_of_file: float,
) -> tuple[float, tuple[float, float]]:
    """Noise of the load Q of the rows of a measured loop, and two changes of the fitted friction
    coefficient f that it may cause. The noise is a standard deviation [force per thickness].

    Noise leaves a small error in the place of the rows on the cycle, and in the scale of their
    load. Displacements compared at shifted times open a loop. So f is fitted again with all rows
    late, and with the scene's load larger, each by 1.96 standard errors.

    Parameters
    ----------
    search
        finds the f that fits best
    alignment
        share of the scene's cycle that is over at each row (n,), and scale of its Q over the
        scene's
    log_friction_bounds
        values of ln f between which it is sought
    friction_of_file
        the fitted f of the file, which is the scale times that of the scene
    """
    # standard errors of the place on the cycle and of the scale, over itself
    noise_of_load, place_error, scale_error = _noise_of_load(
        search.loop, alignment.share_of_cycle, alignment.load_scale, search.load_of_cycle
    )
    late_alignment = alignment._replace(
        share_of_cycle=np.mod(alignment.share_of_cycle + 1.96 * place_error, 1.0)
    )
    larger_alignment = alignment._replace(
        load_scale=alignment.load_scale * (1 + 1.96 * scale_error)
    )
    log_friction_if_late = search.best_log_friction(log_friction_bounds, late_alignment)
    log_friction_if_larger = search.best_log_friction(log_friction_bounds, larger_alignment)
    change_if_late = alignment.load_scale * math.exp(log_friction_if_late) - friction_of_file
    change_if_larger = (
        larger_alignment.load_scale * math.exp(log_friction_if_larger) - friction_of_file
    )
    return noise_of_load, (change_if_late, change_if_larger)


def _noise_of_load(
    measured_loop: MeasuredLoop, share_of_cycle: Array, load_scale: float, load_of_cycle: Array
) -> tuple[float, float, float]:
    """Noise of the load Q of the rows of a measured loop: its standard deviation about r Q of the
    scene [force per thickness]. With it come the standard errors that it leaves in the place on the
    cycle [share of a cycle] and in r, over r.

    Parameters
    ----------
    share_of_cycle
        (n,) share of the scene's cycle that is over at each row
    load_scale
        r, the file's Q over the scene's
    load_of_cycle
        (n_instants,) Q of the scene at the instants `SHARES_OF_CYCLE` of its cycle
    """
    scene_load = load_scale * np.interp(share_of_cycle, SHARES_OF_CYCLE, load_of_cycle)
    load_from_mean = scene_load - scene_load.mean()
    noise = float(np.std(measured_loop.load - scene_load))
    # slope of r Q over the share of the cycle, at the middle between two instants
    # N_INSTANTS: number of these instants, the last one being the first again
    slopes = load_scale * np.diff(load_of_cycle) * (N_INSTANTS - 1)
    middles = (SHARES_OF_CYCLE[1:] + SHARES_OF_CYCLE[:-1]) / 2
    slope_at_rows = np.interp(share_of_cycle, middles, slopes, period=1.0)
    place_error = noise / math.sqrt(float(slope_at_rows @ slope_at_rows))
    scale_error = noise / math.sqrt(float(load_from_mean @ load_from_mean))
    return noise, place_error, scale_error
