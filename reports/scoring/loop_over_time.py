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
from typing import Any, NamedTuple

import numpy as np

from reports.scoring.loop_fitted import FittedLoop, against_rows, said_of_scale
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
    """f of a measured loop whose Q has more than two turning points a cycle, with its 95 %
    interval.

    Each row is placed on the scene's cycle by its time. Then theory's U(tau; f) is compared with U
    of the rows: f is where the sum of squares is least.

    Parameters
    ----------
    rig_compliance
        C of the rig between the places where U is measured [1/stress]; None fits it too
    """
    from scipy.optimize import brentq, minimize_scalar

    place = _on_the_cycle(loop, scene)
    share = place.share
    scale = place.scale
    load_of_cycle = cycle_loads(scene)[1]
    rig_is_fitted = rig_compliance is None
    least_f = least_friction(scene)

    def sum_of_squares(log_friction: float, share: Array = share, scale: float = scale) -> float:
        shift = theory_shift(scene, math.exp(log_friction))
        return against_rows(loop, shift, share, scale * load_of_cycle, scale, rig_compliance)[0]

    trials = np.log(least_f) + np.linspace(1e-6, math.log(_WIDEST), _SCANNED)
    sums = np.array([sum_of_squares(trial) for trial in trials.tolist()])
    best_trial = int(np.argmin(sums))
    search_range = trials[max(best_trial - 1, 0)], trials[min(best_trial + 1, _SCANNED - 1)]

    def best_of(*share_and_scale: Any) -> float:
        return float(
            minimize_scalar(
                sum_of_squares,
                bounds=search_range,
                args=share_and_scale,
                method="bounded",
                options={"xatol": 1e-7},
            ).x
        )

    log_friction_best = min(best_of(), float(trials[best_trial]), key=sum_of_squares)
    best_shift = theory_shift(scene, math.exp(log_friction_best))
    least_sum, compliance, _ = against_rows(
        loop, best_shift, share, scale * load_of_cycle, scale, rig_compliance
    )
    degrees_of_freedom = len(share) - 3 - rig_is_fitted
    # The scatter is at least what the digits of the rows leave.
    noise = max(math.sqrt(least_sum / degrees_of_freedom), loop.resolution[0] / math.sqrt(12))
    limit = least_sum + _CHI * noise**2
    friction = scale * math.exp(log_friction_best)

    def distance_to_limit(trials_beyond: Array) -> float:
        """Distance from the best f to the f at which the sum of squares passes the limit, on the
        way to the nearest of `trials_beyond` it (ln f); infinite without any.
        """
        if not len(trials_beyond):
            return math.inf
        nearest_beyond = trials_beyond[np.argmin(np.abs(trials_beyond - log_friction_best))]
        log_at_limit = brentq(
            lambda trial: sum_of_squares(trial) - limit,
            log_friction_best,
            nearest_beyond,
            xtol=1e-7,
        )
        return abs(scale * math.exp(log_at_limit) - friction)

    exceeds_limit = sums > limit
    distance_down = distance_to_limit(trials[exceeds_limit & (trials < log_friction_best)])
    distance_up = distance_to_limit(trials[exceeds_limit & (trials > log_friction_best)])
    # Noise of Q leaves place and size of the load open. A loop that is shifted in time opens: f is
    # found again with each.
    noise_of_load, place_error, scale_error = _noise_of_load(loop, share, scale, load_of_cycle)
    late_share = np.mod(share + 1.96 * place_error, 1.0)
    large_scale = scale * (1 + 1.96 * scale_error)
    change_if_late = scale * math.exp(best_of(late_share, scale)) - friction
    change_if_large = large_scale * math.exp(best_of(share, large_scale)) - friction
    sampling_error = friction * _OF_THEORY
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
        low=max(
            friction - math.hypot(distance_down, sampling_error, change_if_late, change_if_large),
            scale * least_f,
        ),
        high=None
        if math.isinf(distance_up)
        else friction + math.hypot(distance_up, sampling_error, change_if_late, change_if_large),
        compliance=compliance,
        share=share,
        phase=loop.time / place.period,
        cycles=cycles,
        scale=scale,
        offset=place.offset,
        shift_noise=noise,
        load_noise=max(noise_of_load, loop.resolution[1] / math.sqrt(12)),
        said=tuple(sentences),
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
    """The fit of the scene's Q to Q of the rows, by their times: where on the cycle each row lies,
    with the file's period, scale and offset of Q.

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
    """Period, phase, scale and offset at which Q of the scene's cycle follows Q of the rows best.

    The longest wave in the spectrum of the file's Q gives the first guesses of the period; each is
    tried at 24 phases, and the best one is refined.

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
    even_times = np.linspace(0.0, loop.time[-1], min(n_rows, 4096))
    wave = np.interp(even_times, loop.time, loop.load)
    spectrum = np.abs(np.fft.rfft((wave - wave.mean()) * np.hanning(len(wave)), 8 * len(wave)))
    period_of_spectrum = loop.time[-1] * len(even_times) / (len(even_times) - 1)
    # The spectrum has eight lines to a cycle; the first four belong to the mean.
    most_cycles = min(_MOST_CYCLES, len(even_times) // 4)
    cycles_in_rows = float(np.argmax(spectrum[4 : 8 * most_cycles]) + 4) / 8
    first_frequency = max(cycles_in_rows, 0.5) / period_of_spectrum

    def fit_of(frequency: float, phase: float) -> tuple[float, Array, float, float]:
        """Root mean square misfit of Q, share of the cycle at each row, r and Q0."""
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

    # The highest line of a cycle with several waves may be its second or third.
    frequencies = [
        first_frequency / n_waves * factor for n_waves in (1, 2, 3) for factor in (0.94, 1.0, 1.06)
    ]
    if first_frequency * period_of_spectrum < 3:  # a spectrum of a few cycles has no sharp line
        frequencies += (np.arange(0.9, 3.0, 0.05) / period_of_spectrum).tolist()
    long_enough = [
        frequency for frequency in frequencies if frequency * loop.time[-1] >= least_cycles
    ]
    frequencies = long_enough or frequencies
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
    rate = np.interp(
        share,
        (SHARES[1:] + SHARES[:-1]) / 2,
        scale * np.diff(load_of_cycle) * (INSTANTS - 1),
        period=1.0,
    )
    place_error = noise / math.sqrt(float(rate @ rate))
    scale_error = noise / math.sqrt(float(load_from_mean @ load_from_mean))
    return noise, place_error, scale_error
