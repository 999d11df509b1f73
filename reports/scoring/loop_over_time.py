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


def fit_over_time(loop: MeasuredLoop, scene: Scene, rig_compliance: float | None) -> FittedLoop:
    """Fit the friction coefficient f to a measured loop whose tangential load Q has more than two
    turning points a cycle, with the 95 % interval of f.

    Each row is placed on the scene's cycle by its time. Then theory's displacement U for trial
    values of f is compared with U of the rows: f is where the sum of squares is least. The upper
    end of the interval is None where the sum never exceeds its limit.

    Parameters
    ----------
    loop
        U, Q and time of the rows; `resolution`, steps of U and Q that their digits resolve
    rig_compliance
        compliance C of the rig between the places where U is measured [1/stress]; None fits it too

    # notation: P normal load
    """
    # period; share of the cycle that is over at each row; scale and offset of Q over the scene's
    alignment = _required_alignment(loop, scene)
    # The file's Q is r times the scene's (r: `scale`), at the same P: so is f.
    scale = alignment.scale
    # sums of squared differences of U between theory and rows, for any f
    search = _Search(loop, scene, cycle_loads(scene)[1], rig_compliance)
    # f at which the contact just slides as a whole at the scene's loads
    least_scene_friction = friction_at_gross_sliding(scene)

    # scan of trial values of ln f of the scene, then the best value between the neighbours of the
    # best trial
    log_trials = np.log(least_scene_friction) + np.linspace(
        1e-6, math.log(_LARGEST_FRICTION_RATIO), _N_TRIALS
    )
    sums_of_squares = np.array(
        [
            search.sum_of_squares(log_trial, alignment.share_of_cycle, scale)
            for log_trial in log_trials.tolist()
        ]
    )
    index_of_best = int(np.argmin(sums_of_squares))
    neighbours_of_best = (
        float(log_trials[max(index_of_best - 1, 0)]),
        float(log_trials[min(index_of_best + 1, _N_TRIALS - 1)]),
    )
    log_friction = min(
        search.best_log_friction(neighbours_of_best, alignment.share_of_cycle, scale),
        float(log_trials[index_of_best]),
        key=lambda log_trial: search.sum_of_squares(log_trial, alignment.share_of_cycle, scale),
    )
    # rig whose C Q + U0 (compliance C, origin U0), added to theory's U, fits the rows best
    least_sum, compliance, _ = search.rig_fit(log_friction, alignment.share_of_cycle, scale)
    degrees_of_freedom = len(loop.time) - 3 - (rig_compliance is None)
    # The scatter is at least what the digits of the rows leave.
    noise = max(math.sqrt(least_sum / degrees_of_freedom), loop.resolution[0] / math.sqrt(12))
    friction = scale * math.exp(log_friction)

    # ends of the interval by the scatter of the rows; 3.841: chi squared of one degree, 95 %
    limit = least_sum + _CHI_SQUARED * noise**2
    trials_outside = log_trials[sums_of_squares > limit]
    trials_below = trials_outside[trials_outside < log_friction]
    trials_above = trials_outside[trials_outside > log_friction]
    log_at_lower_end = search.log_friction_at_limit(limit, log_friction, trials_below, alignment)
    log_at_upper_end = search.log_friction_at_limit(limit, log_friction, trials_above, alignment)
    distance_to_lower_end = abs(scale * math.exp(log_at_lower_end) - friction)
    distance_to_upper_end = abs(scale * math.exp(log_at_upper_end) - friction)

    # error of f, since noise of Q leaves the place and the size of the rows' loads uncertain
    noise_of_load, changes_of_friction = _friction_changes_by_load_noise(
        search, alignment, neighbours_of_best, friction
    )
    errors_beside_scatter = (friction * _RELATIVE_ERROR_OF_THEORY, *changes_of_friction)
    lowest_friction = friction - math.hypot(distance_to_lower_end, *errors_beside_scatter)
    highest_friction = None
    if not math.isinf(distance_to_upper_end):
        highest_friction = friction + math.hypot(distance_to_upper_end, *errors_beside_scatter)
    n_cycles = float(loop.time[-1] / alignment.period)
    sentences = [
        (
            f"The rows cover {n_cycles:.4g} cycles and follow the scene's Q over time to"
            f" {100 * alignment.misfit:.2g} % of its amplitude"
        ),
        *sentences_on_scale(scale),
    ]
    return FittedLoop(
        scene=scene,
        friction=friction,
        lowest_friction=max(lowest_friction, scale * least_scene_friction),
        highest_friction=highest_friction,
        compliance=compliance,
        share_of_cycle=alignment.share_of_cycle,
        phase=loop.time / alignment.period,
        n_cycles=n_cycles,
        scale=scale,
        offset=alignment.offset,
        displacement_noise=noise,
        load_noise=max(noise_of_load, loop.resolution[1] / math.sqrt(12)),
        sentences=tuple(sentences),
    )


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

    def rig_fit(
        self, log_friction: float, share_of_cycle: Array, scale: float
    ) -> tuple[float, float, float]:
        """Fit a rig to theory's loop of Q over U and the rows of a measured one: U = r U_theory + C
        r Q + U0, with Q of the scene. Returns the sum of squared residuals of U [length^2], the
        rig's compliance C [1/stress] and origin U0 [length].

        Parameters
        ----------
        log_friction
            ln of the scene's friction coefficient f
        share_of_cycle
            (n,) share of the scene's cycle that is over at each row
        scale
            r, the file's Q over the scene's

        # notation: Q tangential load, U relative tangential displacement
        """
        displacement = theory_displacement(self.scene, math.exp(log_friction))
        load = scale * self.load_of_cycle
        return fit_rig(self.loop, displacement, share_of_cycle, load, scale, self.rig_compliance)

    def sum_of_squares(self, log_friction: float, share_of_cycle: Array, scale: float) -> float:
        """Sum of squared residuals of U of the rows with this ln f of the scene [length^2]."""
        return self.rig_fit(log_friction, share_of_cycle, scale)[0]

    def best_log_friction(
        self, log_friction_bounds: tuple[float, float], share_of_cycle: Array, scale: float
    ) -> float:
        """ln of the scene's friction coefficient f, between two bounds, at which the sum of squared
        differences of U (displacement) between theory and measured rows is least.

        Parameters
        ----------
        share_of_cycle
            (n,) share of the scene's cycle that is over at each row
        scale
            r, the file's Q over the scene's

        # notation: Q tangential load
        """
        from scipy.optimize import minimize_scalar

        minimum = minimize_scalar(
            self.sum_of_squares,
            bounds=log_friction_bounds,
            args=(share_of_cycle, scale),
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
            sum_of_squares = self.sum_of_squares(
                log_friction, alignment.share_of_cycle, alignment.scale
            )
            return sum_of_squares - limit

        return float(brentq(excess, best_log_friction, nearest_trial, xtol=1e-7))


class _Alignment(NamedTuple):
    """Where the rows lie on the scene's cycle.

    Attributes
    ----------
    share_of_cycle
        (n,) share of the cycle that is over at each row, 0 to 1
    scale, offset
        r and Q0 with which the file's Q is r Q + Q0 of the scene
    period
        of the cycle, in the file's unit of time
    misfit
        root mean square of the file's Q − (r Q + Q0), over the amplitude of r Q
    """

    share_of_cycle: Array
    scale: float
    offset: float
    period: float
    misfit: float


def _required_alignment(loop: MeasuredLoop, scene: Scene) -> _Alignment:
    """Find where on the scene's cycle each row of a measured loop lies, by its time, and the file's
    period, scale and offset of Q: those with which the scene's Q fits that of the rows best.

    Raises
    ------
    InputError
        For less than 0.9 of a cycle, and for rows whose Q differs from the scene's by more than 15
        % of its amplitude (`misfit`, root mean square).

    # notation: Q tangential load
    """
    load_of_cycle = cycle_loads(scene)[1]
    # Where Q goes straight between its turning points, rows of one cycle also fit half of a cycle
    # that is twice as large. So trial periods of which the rows cover 0.9 and more come first.
    alignment = _best_alignment(loop, load_of_cycle, _FEWEST_CYCLES)
    if alignment.misfit > _LARGEST_MISFIT:
        alignment = _best_alignment(loop, load_of_cycle)
    n_cycles = loop.time[-1] / alignment.period
    if alignment.misfit > _LARGEST_MISFIT:
        raise InputError(
            f"{loop.source}: its Q follows that of {scene.name} to {100 * alignment.misfit:.0f} %"
            f" of its amplitude only (limit {100 * _LARGEST_MISFIT:.0f} %): give a column time,"
            " whole cycles, and a scene with this form of Q"
        )
    if n_cycles < _FEWEST_CYCLES:
        raise InputError(
            f"{loop.source}: its rows cover {n_cycles:.2g} of a cycle: a loop needs a whole one"
        )
    return alignment


def _best_alignment(
    loop: MeasuredLoop, load_of_cycle: Array, least_cycles: float = 0.0
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
    from scipy.optimize import minimize

    if not np.ptp(load_of_cycle) > 0:
        raise InputError("the scene's Q stands still: there is no loop")
    amplitude = np.ptp(load_of_cycle) / 2
    n_rows = len(loop.load)

    def alignment_at(frequency: float, phase: float) -> _Alignment:
        """Where the measured rows lie on the scene's cycle, for a given frequency of the cycle and
        its phase (share of a cycle at time 0). Scale and offset of Q are those that fit the
        measured Q best. `load_of_cycle` is Q of the scene at the shares of its cycle,
        `SHARES_OF_CYCLE`; `loop` holds time and Q of the n rows.

        The misfit is a force per thickness here, not yet over the amplitude: the root mean square
        of the measured Q minus this fit. Where the scale is not positive, ten times the range of Q
        is added to it, so that another alignment is taken.

        # notation: Q tangential load
        """
        share_of_cycle = np.mod(frequency * loop.time + phase, 1.0)
        scene_load = np.interp(share_of_cycle, SHARES_OF_CYCLE, load_of_cycle)
        columns = np.column_stack([scene_load, np.ones(n_rows)])
        scale, offset = np.linalg.lstsq(columns, loop.load, rcond=None)[0].tolist()
        residuals = loop.load - scale * scene_load - offset
        misfit = float(np.sqrt(residuals @ residuals / n_rows))
        # A negative scale fits a sine as well as a positive one does half a cycle later: only the
        # positive one counts.
        if scale <= 0:
            misfit += 10 * float(np.ptp(loop.load))
        return _Alignment(share_of_cycle, scale, offset, float(1 / frequency), misfit)

    # frequencies of the cycle, and that at which the spectrum of Q is highest
    frequencies, first_frequency = _trial_frequencies(loop, least_cycles)
    trials = [(frequency, phase) for frequency in frequencies for phase in np.arange(24) / 24]
    best_trial = min(trials, key=lambda trial: alignment_at(*trial).misfit)
    # This first step of the search moves the last row by a tenth of a cycle; in a record shorter
    # than a cycle, by less.
    frequency_step = 0.3 / max(loop.time[-1] * first_frequency, 1.0) * first_frequency * 0.3
    simplex_steps = np.array([[0.0, 0.0], [frequency_step, 0.0], [0.0, 0.02]])
    minimum = minimize(
        lambda frequency_and_phase: alignment_at(*frequency_and_phase).misfit,
        best_trial,
        method="Nelder-Mead",
        options={
            "initial_simplex": np.array(best_trial) + simplex_steps,
            "xatol": 1e-9 * first_frequency,
            "fatol": 1e-12 * amplitude,
            "maxiter": 800,
        },
    )
    alignment = alignment_at(*minimum.x)
    # from a force to a share of the amplitude
    return alignment._replace(misfit=alignment.misfit / (abs(alignment.scale) * amplitude))


def _trial_frequencies(loop: MeasuredLoop, least_cycles: float) -> tuple[list[float], float]:
    """Frequencies of the cycle to try [cycles per unit of time], from the spectrum of Q of the rows
    of a measured loop; and the frequency at which this spectrum is highest.

    Those by which the rows cover fewer than `least_cycles` are left out, as long as others remain.
    They are the frequency of the peak, its half and its third, and some 6 % beside each.

    # notation: Q tangential load
    """
    # loop.time begins at 0
    even_times = np.linspace(0.0, loop.time[-1], min(len(loop.load), 4096))
    even_loads = np.interp(even_times, loop.time, loop.load)
    load_from_mean = even_loads - even_loads.mean()
    n_times = len(even_times)
    spectrum = np.abs(np.fft.rfft(load_from_mean * np.hanning(n_times), 8 * n_times))
    record_length = loop.time[-1] * n_times / (n_times - 1)
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
        frequency for frequency in frequencies if frequency * loop.time[-1] >= least_cycles
    ]
    return frequencies_of_enough_cycles or frequencies, peak_frequency


def _friction_changes_by_load_noise(
    search: _Search,
    alignment: _Alignment,
    log_friction_bounds: tuple[float, float],
    friction: float,
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
    friction
        the fitted f of the file, which is the scale times that of the scene
    """
    # standard errors of the place on the cycle and of the scale, over itself
    noise_of_load, place_error, scale_error = _noise_of_load(
        search.loop, alignment.share_of_cycle, alignment.scale, search.load_of_cycle
    )
    late_share = np.mod(alignment.share_of_cycle + 1.96 * place_error, 1.0)
    larger_scale = alignment.scale * (1 + 1.96 * scale_error)
    log_friction_if_late = search.best_log_friction(
        log_friction_bounds, late_share, alignment.scale
    )
    log_friction_if_larger = search.best_log_friction(
        log_friction_bounds, alignment.share_of_cycle, larger_scale
    )
    change_if_late = alignment.scale * math.exp(log_friction_if_late) - friction
    change_if_larger = larger_scale * math.exp(log_friction_if_larger) - friction
    return noise_of_load, (change_if_late, change_if_larger)


def _noise_of_load(
    loop: MeasuredLoop, share_of_cycle: Array, scale: float, load_of_cycle: Array
) -> tuple[float, float, float]:
    """Noise of the load Q of the rows of a measured loop: its standard deviation about r Q of the
    scene [force per thickness]. With it come the standard errors that it leaves in the place on the
    cycle [share of a cycle] and in r, over r.

    Parameters
    ----------
    share_of_cycle
        (n,) share of the scene's cycle that is over at each row
    scale
        r, the file's Q over the scene's
    load_of_cycle
        (n_instants,) Q of the scene at the instants `SHARES_OF_CYCLE` of its cycle
    """
    scene_load = scale * np.interp(share_of_cycle, SHARES_OF_CYCLE, load_of_cycle)
    load_from_mean = scene_load - scene_load.mean()
    noise = float(np.std(loop.load - scene_load))
    # slope of r Q over the share of the cycle, at the middle between two instants
    # N_INSTANTS: number of these instants, the last one being the first again
    slopes = scale * np.diff(load_of_cycle) * (N_INSTANTS - 1)
    middles = (SHARES_OF_CYCLE[1:] + SHARES_OF_CYCLE[:-1]) / 2
    slope_at_rows = np.interp(share_of_cycle, middles, slopes, period=1.0)
    place_error = noise / math.sqrt(float(slope_at_rows @ slope_at_rows))
    scale_error = noise / math.sqrt(float(load_from_mean @ load_from_mean))
    return noise, place_error, scale_error
