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

from reports.scoring.loop_fitted import FittedLoop, fit_rig, said_of_scale
from reports.scoring.loop_rows import MeasuredLoop
from reports.scoring.loop_theory import INSTANTS, SHARES, cycle_loads, least_friction, theory_shift
from scenes import InputError, Scene
from scenes.array_types import Array

_LEAST_CYCLES = 0.9
_MOST_CYCLES = 2000
# Coefficients that are scanned, from gross sliding to so many times as much; beyond, a loop is a
# line.
_SCANNED = 60
_WIDEST = 40.0
# Rows that do not follow the scene's Q better than this share of its amplitude are another
# experiment's.
_FOLLOWS = 0.15
# Error of a fitted f by theory at so many instants, straight between, of itself.
_OF_THEORY = 1e-5
# Chance gives so much of the sum of squares over its mean in 95 %: chi squared of one degree.
_CHI = 3.841


def fit_over_time(loop: MeasuredLoop, scene: Scene, rig_compliance: float | None) -> FittedLoop:
    """Fit the friction coefficient f to a measured loop whose tangential load Q has more than two
    turning points a cycle; with its 95 % interval.

    Each row is placed on the scene's cycle by its time. Then theory's displacement U for trial
    values of f is compared with U of the rows: f is where the sum of squares is least.

    Parameters
    ----------
    rig_compliance
        compliance C of the rig between the places where U is measured [1/stress]; None fits it too
    """
    place = _on_the_cycle(loop, scene)
    scale = place.scale
    load_of_cycle = cycle_loads(scene)[1]
    search = _Search(loop, scene, load_of_cycle, rig_compliance)
    least_f = least_friction(scene)

    # scan of ln f, then the best one between the neighbours of the best trial
    trials = np.log(least_f) + np.linspace(1e-6, math.log(_WIDEST), _SCANNED)
    sums = np.array([search.sum_of_squares(trial, place.share, scale) for trial in trials.tolist()])
    best_trial = int(np.argmin(sums))
    neighbours_of_best = (
        float(trials[max(best_trial - 1, 0)]),
        float(trials[min(best_trial + 1, _SCANNED - 1)]),
    )
    log_friction = min(
        search.best(neighbours_of_best, place.share, scale),
        float(trials[best_trial]),
        key=lambda trial: search.sum_of_squares(trial, place.share, scale),
    )
    least_sum, compliance, _ = search.against_theory(log_friction, place.share, scale)
    degrees_of_freedom = len(place.share) - 3 - (rig_compliance is None)
    # The scatter is at least what the digits of the rows leave.
    noise = max(math.sqrt(least_sum / degrees_of_freedom), loop.resolution[0] / math.sqrt(12))
    friction = scale * math.exp(log_friction)

    # ends of the interval by the scatter of the rows
    limit = least_sum + _CHI * noise**2
    trials_beyond = trials[sums > limit]
    trials_below = trials_beyond[trials_beyond < log_friction]
    trials_above = trials_beyond[trials_beyond > log_friction]
    log_at_lower_end = search.where_it_passes(limit, log_friction, trials_below, place)
    log_at_upper_end = search.where_it_passes(limit, log_friction, trials_above, place)
    distance_down = abs(scale * math.exp(log_at_lower_end) - friction)
    distance_up = abs(scale * math.exp(log_at_upper_end) - friction)

    noise_of_load, changes_of_friction = _by_noise_of_load(
        search, place, neighbours_of_best, friction
    )
    other_errors = (friction * _OF_THEORY, *changes_of_friction)
    cycles = float(loop.time[-1] / place.period)
    sentences = [
        (
            f"The rows cover {cycles:.4g} cycles and follow the scene's Q over time to"
            f" {100 * place.misfit:.2g} % of its amplitude"
        ),
        *said_of_scale(scale),
    ]
    return FittedLoop(
        scene=scene,
        friction=friction,
        low=max(friction - math.hypot(distance_down, *other_errors), scale * least_f),
        high=None if math.isinf(distance_up) else friction + math.hypot(distance_up, *other_errors),
        compliance=compliance,
        share=place.share,
        phase=loop.time / place.period,
        cycles=cycles,
        scale=scale,
        offset=place.offset,
        shift_noise=noise,
        load_noise=max(noise_of_load, loop.resolution[1] / math.sqrt(12)),
        said=tuple(sentences),
    )


@dataclass(frozen=True, eq=False)
class _Search:
    """How far U of the rows is from theory's U(tau; f), as a function of f.

    Attributes
    ----------
    load_of_cycle
        Q of the scene at the instants `SHARES` of its cycle
    rig_compliance
        C [1/stress]; None fits it for each f
    """

    loop: MeasuredLoop
    scene: Scene
    load_of_cycle: Array
    rig_compliance: float | None

    def against_theory(
        self, log_friction: float, share: Array, scale: float
    ) -> tuple[float, float, float]:
        """Sum of squares of U of the rows minus that of theory with a rig, and the C and U0 of this
        rig.

        Parameters
        ----------
        log_friction
            ln f of the scene
        share
            (n,) place of the rows on the cycle
        scale
            r, the file's Q over the scene's
        """
        displacement = theory_shift(self.scene, math.exp(log_friction))
        load = scale * self.load_of_cycle
        return fit_rig(self.loop, displacement, share, load, scale, self.rig_compliance)

    def sum_of_squares(self, log_friction: float, share: Array, scale: float) -> float:
        """The sum of squares alone."""
        return self.against_theory(log_friction, share, scale)[0]

    def best(self, between: tuple[float, float], share: Array, scale: float) -> float:
        """The friction coefficient f at which the sum of squares between theory and rows is least,
        as ln f, among those between the two values of ln f in `between`. `share` (n,) is where the
        rows lie on the cycle, `scale` the factor from the scene's Q to that of the rows.
        """
        from scipy.optimize import minimize_scalar

        minimum = minimize_scalar(
            self.sum_of_squares,
            bounds=between,
            args=(share, scale),
            method="bounded",
            options={"xatol": 1e-7},
        )
        return float(minimum.x)

    def where_it_passes(
        self, limit: float, log_friction: float, trials_beyond: Array, place: _Place
    ) -> float:
        """The ln f at which the sum of squares of a fit passes `limit`, on the way from the best
        one, `log_friction`, to the nearest of the trials at which it lies beyond. Infinite without
        any. `place` holds where the rows lie on the scene's cycle, as a share of it, and the factor
        of their loads.
        """
        from scipy.optimize import brentq

        if not len(trials_beyond):
            return math.inf
        nearest_beyond = trials_beyond[np.argmin(np.abs(trials_beyond - log_friction))]
        return float(
            brentq(
                lambda trial: self.sum_of_squares(trial, place.share, place.scale) - limit,
                log_friction,
                nearest_beyond,
                xtol=1e-7,
            )
        )


class _Place(NamedTuple):
    """Where the rows lie on the scene's cycle.

    Attributes
    ----------
    share
        (n,) share of the cycle that is over at each row, 0 to 1
    scale, offset
        r and Q0 with which the file's Q is r Q(tau) + Q0
    period
        of the cycle, in the file's unit of time
    misfit
        root mean square of the file's Q − (r Q + Q0), over the amplitude of r Q
    """

    share: Array
    scale: float
    offset: float
    period: float
    misfit: float


def _on_the_cycle(loop: MeasuredLoop, scene: Scene) -> _Place:
    """Where on the scene's cycle each row of a measured loop lies, by its time, and the file's
    period, scale and offset of Q: those with which the scene's Q fits that of the rows.

    Raises
    ------
    InputError
        For less than a cycle, and for rows that do not follow the scene's Q.
    """
    load_of_cycle = cycle_loads(scene)[1]
    # Rows of a whole cycle between straight loads are also half of a cycle twice as large: the
    # whole one counts.
    alignment = _aligned(loop, load_of_cycle, _LEAST_CYCLES)
    if alignment.misfit > _FOLLOWS:
        alignment = _aligned(loop, load_of_cycle)
    cycles = loop.time[-1] / alignment.period
    if alignment.misfit > _FOLLOWS:
        raise InputError(
            f"{loop.source}: its Q follows that of {scene.name} to {100 * alignment.misfit:.0f} %"
            f" of its amplitude only (limit {100 * _FOLLOWS:.0f} %): give a column time, whole"
            " cycles, and a scene with this form of Q"
        )
    if cycles < _LEAST_CYCLES:
        raise InputError(
            f"{loop.source}: its rows cover {cycles:.2g} of a cycle: a loop needs a whole one"
        )
    return alignment


def _aligned(loop: MeasuredLoop, load_of_cycle: Array, least_cycles: float = 0.0) -> _Place:
    """Find where the rows lie on the scene's cycle: period, phase, scale and offset at which Q of
    this cycle follows Q of the rows best.

    Guesses of the period come from the spectrum of the file's Q; each is tried at 24 phases, and
    the best one is refined.

    Parameters
    ----------
    load_of_cycle
        Q of the scene at the instants `SHARES` of its cycle
    least_cycles
        guesses by which the rows cover fewer cycles are left out, as long as others remain
    """
    from scipy.optimize import minimize

    if not np.ptp(load_of_cycle) > 0:
        raise InputError("the scene's Q stands still: there is no loop")
    amplitude = np.ptp(load_of_cycle) / 2
    n_rows = len(loop.load)

    def fit_of(frequency: float, phase: float) -> tuple[float, Array, float, float]:
        """How well Q of the rows follows scale * Q of the scene's cycle + offset, for a frequency
        and phase (share of a cycle at time 0). Returns the root mean square misfit, the share of
        the cycle at each row, scale and offset. A negative scale gets a misfit too large to be the
        best.
        """
        share = np.mod(frequency * loop.time + phase, 1.0)
        scene_load = np.interp(share, SHARES, load_of_cycle)
        columns = np.column_stack([scene_load, np.ones(n_rows)])
        scale, offset = np.linalg.lstsq(columns, loop.load, rcond=None)[0].tolist()
        residual = loop.load - scale * scene_load - offset
        misfit = float(np.sqrt(residual @ residual / n_rows))
        # Turned Q fits a sine as well as Q half a cycle later: only the upright one counts.
        if scale <= 0:
            misfit += 10 * float(np.ptp(loop.load))
        return misfit, share, scale, offset

    frequencies, first_frequency = _trial_frequencies(loop, least_cycles)
    starts = [(frequency, phase) for frequency in frequencies for phase in np.arange(24) / 24]
    start = min(starts, key=lambda start: fit_of(*start)[0])
    frequency_step = 0.3 / max(loop.time[-1] * first_frequency, 1.0) * first_frequency * 0.3
    simplex_steps = np.array([[0.0, 0.0], [frequency_step, 0.0], [0.0, 0.02]])
    minimum = minimize(
        lambda point: fit_of(*point)[0],
        start,
        method="Nelder-Mead",
        options={
            "initial_simplex": np.array(start) + simplex_steps,
            "xatol": 1e-9 * first_frequency,
            "fatol": 1e-12 * amplitude,
            "maxiter": 800,
        },
    )
    misfit, share, scale, offset = fit_of(*minimum.x)
    return _Place(share, scale, offset, float(1 / minimum.x[0]), misfit / (abs(scale) * amplitude))


def _trial_frequencies(loop: MeasuredLoop, least_cycles: float) -> tuple[list[float], float]:
    """Frequencies of the cycle to try [cycles per unit of time], from the spectrum of Q of the
    rows; and the frequency of its highest line.

    Those by which the rows cover fewer than `least_cycles` are left out, as long as others remain.
    """
    even_times = np.linspace(0.0, loop.time[-1], min(len(loop.load), 4096))
    wave = np.interp(even_times, loop.time, loop.load)
    spectrum = np.abs(np.fft.rfft((wave - wave.mean()) * np.hanning(len(wave)), 8 * len(wave)))
    period_of_spectrum = loop.time[-1] * len(even_times) / (len(even_times) - 1)
    # The spectrum has eight lines to a cycle; the first four belong to the mean.
    most_cycles = min(_MOST_CYCLES, len(even_times) // 4)
    cycles_in_rows = float(np.argmax(spectrum[4 : 8 * most_cycles]) + 4) / 8
    first_frequency = max(cycles_in_rows, 0.5) / period_of_spectrum
    # The highest line of a cycle with several waves may be its second or third.
    frequencies = [
        first_frequency / n_waves * factor for n_waves in (1, 2, 3) for factor in (0.94, 1.0, 1.06)
    ]
    if first_frequency * period_of_spectrum < 3:  # a spectrum of a few cycles has no sharp line
        frequencies += (np.arange(0.9, 3.0, 0.05) / period_of_spectrum).tolist()
    long_enough = [
        frequency for frequency in frequencies if frequency * loop.time[-1] >= least_cycles
    ]
    return long_enough or frequencies, first_frequency


def _by_noise_of_load(
    search: _Search, place: _Place, neighbours_of_best: tuple[float, float], friction: float
) -> tuple[float, tuple[float, float]]:
    """Noise of the load Q of the rows [force per thickness], and what it may change in the fitted
    friction coefficient f: it leaves open when the load acts and how large it is. Since a loop that
    is shifted in time opens, f is found again with the rows late, and with the load large.

    Parameters
    ----------
    search
        finds the f that fits best
    place
        where the rows lie on the scene's cycle
    neighbours_of_best
        values of ln f between which it is sought
    friction
        the fitted f
    """
    noise_of_load, place_error, scale_error = _noise_of_load(
        search.loop, place.share, place.scale, search.load_of_cycle
    )
    late_share = np.mod(place.share + 1.96 * place_error, 1.0)
    large_scale = place.scale * (1 + 1.96 * scale_error)
    log_if_late = search.best(neighbours_of_best, late_share, place.scale)
    log_if_large = search.best(neighbours_of_best, place.share, large_scale)
    change_if_late = place.scale * math.exp(log_if_late) - friction
    change_if_large = large_scale * math.exp(log_if_large) - friction
    return noise_of_load, (change_if_late, change_if_large)


def _noise_of_load(
    loop: MeasuredLoop, share: Array, scale: float, load_of_cycle: Array
) -> tuple[float, float, float]:
    """Standard deviation of Q of the rows about r Q of the scene [force per thickness], and the
    standard errors that it leaves in the place on the cycle [share of a cycle] and in r, over r.

    Parameters
    ----------
    share
        (n,) place of the rows on the cycle
    scale
        r
    load_of_cycle
        Q of the scene at the instants `SHARES` of its cycle
    """
    scene_load = scale * np.interp(share, SHARES, load_of_cycle)
    load_from_mean = scene_load - scene_load.mean()
    noise = float(np.std(loop.load - scene_load))
    load_per_cycle = np.interp(
        share,
        (SHARES[1:] + SHARES[:-1]) / 2,
        scale * np.diff(load_of_cycle) * (INSTANTS - 1),
        period=1.0,
    )
    place_error = noise / math.sqrt(float(load_per_cycle @ load_per_cycle))
    scale_error = noise / math.sqrt(float(load_from_mean @ load_from_mean))
    return noise, place_error, scale_error
