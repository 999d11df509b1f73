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
    """Where Q has more turning points in a cycle: by the scene's loads at the times of the rows."""
    from scipy.optimize import brentq, minimize_scalar

    place = _on_the_cycle(loop, scene)
    share = place.share
    scale = place.scale
    tangential = cycle_loads(scene)[1]
    fitted = rig_compliance is None
    least = least_friction(scene)

    def squares(log_friction: float, share: Array = share, scale: float = scale) -> float:
        shift = theory_shift(scene, math.exp(log_friction))
        return against_rows(loop, shift, share, scale * tangential, scale, rig_compliance)[0]

    trials = np.log(least) + np.linspace(1e-6, math.log(_WIDEST), _SCANNED)
    sums = np.array([squares(trial) for trial in trials.tolist()])
    best = int(np.argmin(sums))
    ends = trials[max(best - 1, 0)], trials[min(best + 1, _SCANNED - 1)]

    def best_of(*where: Any) -> float:
        return float(
            minimize_scalar(
                squares, bounds=ends, args=where, method="bounded", options={"xatol": 1e-7}
            ).x
        )

    at = min(best_of(), float(trials[best]), key=squares)
    best_shift = theory_shift(scene, math.exp(at))
    lowest, compliance, _ = against_rows(
        loop, best_shift, share, scale * tangential, scale, rig_compliance
    )
    freedom = len(share) - 3 - fitted
    # The scatter is at least what the digits of the rows leave.
    noise = max(math.sqrt(lowest / freedom), loop.resolution[0] / math.sqrt(12))
    limit = lowest + _CHI * noise**2
    friction = scale * math.exp(at)

    def apart(beyond: Array) -> float:
        """How far the f is at which the sum of squares passes the limit, on the way to the nearest
        trial where it has.
        """
        if not len(beyond):
            return math.inf
        far = beyond[np.argmin(np.abs(beyond - at))]
        return abs(
            scale * math.exp(brentq(lambda z: squares(z) - limit, at, far, xtol=1e-7)) - friction
        )

    down, up = (apart(trials[(sums > limit) & side]) for side in (trials < at, trials > at))
    # Noise of Q leaves place and size of the load open. A loop that is shifted in time opens: f is
    # found again with each.
    noise_of_load, place_error, scale_error = _noise_of_load(loop, share, scale, tangential)
    others = (
        (np.mod(share + 1.96 * place_error, 1.0), scale),
        (
            share,
            scale * (1 + 1.96 * scale_error),
        ),
    )
    moved = [other[1] * math.exp(best_of(*other)) - friction for other in others]
    own = friction * _OF_THEORY
    cycles = float(loop.time[-1] / place.period)
    said = [
        (
            f"The rows cover {cycles:.4g} cycles and follow the scene's Q over time to"
            f" {100 * place.misfit:.2g} % of its amplitude"
        ),
        *said_of_scale(scale),
    ]
    return FittedLoop(
        scene=scene,
        friction=friction,
        low=max(friction - math.hypot(down, own, *moved), scale * least),
        high=None if math.isinf(up) else friction + math.hypot(up, own, *moved),
        compliance=compliance,
        share=share,
        phase=loop.time / place.period,
        cycles=cycles,
        scale=scale,
        offset=place.offset,
        shift_noise=noise,
        load_noise=max(noise_of_load, loop.resolution[1] / math.sqrt(12)),
        said=tuple(said),
    )


class _Place(NamedTuple):
    """Where rows lie on the cycle (n,); r, Q0 of the file, the period in its time; misfit of Q over
    its amplitude.
    """

    share: Array
    scale: float
    offset: float
    period: float
    misfit: float


def _on_the_cycle(loop: MeasuredLoop, scene: Scene) -> _Place:
    """The place of the rows on the scene's cycle, by their times.

    Raises
    ------
    InputError
        For less than a cycle, and for rows that do not follow the scene's Q.
    """
    tangential = cycle_loads(scene)[1]
    # Rows of a whole cycle between straight loads are also half of a cycle twice as large: the
    # whole one counts.
    place = _aligned(loop, tangential, _LEAST_CYCLES)
    if place.misfit > _FOLLOWS:
        place = _aligned(loop, tangential)
    cycles = loop.time[-1] / place.period
    if place.misfit > _FOLLOWS:
        raise InputError(
            f"{loop.source}: its Q follows that of {scene.name} to {100 * place.misfit:.0f} % of"
            f" its amplitude only (limit {100 * _FOLLOWS:.0f} %): give a column time, whole cycles,"
            " and a scene with this form of Q"
        )
    if cycles < _LEAST_CYCLES:
        raise InputError(
            f"{loop.source}: its rows cover {cycles:.2g} of a cycle: a loop needs a whole one"
        )
    return place


def _aligned(loop: MeasuredLoop, tangential: Array, least_cycles: float = 0.0) -> _Place:
    """The place of the rows that fits this Q of a cycle best, from starts of at least so many
    cycles.
    """
    from scipy.optimize import minimize

    if not np.ptp(tangential) > 0:
        raise InputError("the scene's Q stands still: there is no loop")
    amplitude = np.ptp(tangential) / 2
    count = len(loop.load)
    even = np.linspace(0.0, loop.time[-1], min(count, 4096))
    wave = np.interp(even, loop.time, loop.load)
    spectrum = np.abs(np.fft.rfft((wave - wave.mean()) * np.hanning(len(wave)), 8 * len(wave)))
    span = loop.time[-1] * len(even) / (len(even) - 1)
    first = (
        max(float(np.argmax(spectrum[4 : 8 * min(_MOST_CYCLES, len(even) // 4)]) + 4) / 8, 0.5)
        / span
    )

    def parts(frequency: float, phase: float) -> tuple[float, Array, float, float]:
        share = np.mod(frequency * loop.time + phase, 1.0)
        own = np.interp(share, SHARES, tangential)
        columns = np.column_stack([own, np.ones(count)])
        scale, offset = np.linalg.lstsq(columns, loop.load, rcond=None)[0].tolist()
        rest = loop.load - scale * own - offset
        # Turned Q fits a sine as well as Q half a cycle later: only the upright one counts.
        return (
            float(np.sqrt(rest @ rest / count))
            + (0.0 if scale > 0 else 10 * float(np.ptp(loop.load))),
            share,
            scale,
            offset,
        )

    # The highest line of a cycle with several waves may be its second or third.
    frequencies = [first / wave * factor for wave in (1, 2, 3) for factor in (0.94, 1.0, 1.06)]
    if first * span < 3:  # a spectrum of a few cycles has no sharp line
        frequencies += (np.arange(0.9, 3.0, 0.05) / span).tolist()
    frequencies = [
        frequency for frequency in frequencies if frequency * loop.time[-1] >= least_cycles
    ] or frequencies
    starts = [(frequency, phase) for frequency in frequencies for phase in np.arange(24) / 24]
    start = min(starts, key=lambda one: parts(*one)[0])
    step = np.array(
        [[0.0, 0.0], [0.3 / max(loop.time[-1] * first, 1.0) * first * 0.3, 0.0], [0.0, 0.02]]
    )
    found = minimize(
        lambda z: parts(*z)[0],
        start,
        method="Nelder-Mead",
        options={
            "initial_simplex": np.array(start) + step,
            "xatol": 1e-9 * first,
            "fatol": 1e-12 * amplitude,
            "maxiter": 800,
        },
    )
    misfit, share, scale, offset = parts(*found.x)
    return _Place(share, scale, offset, float(1 / found.x[0]), misfit / (abs(scale) * amplitude))


def _noise_of_load(
    loop: MeasuredLoop, share: Array, scale: float, tangential: Array
) -> tuple[float, float, float]:
    """Of Q: its noise, and the standard errors that this leaves in the place on the cycle [share]
    and in r, over r.
    """
    own = scale * np.interp(share, SHARES, tangential)
    rest = loop.load - own
    apart = own - own.mean()
    noise = float(np.std(rest))
    rate = np.interp(
        share,
        (SHARES[1:] + SHARES[:-1]) / 2,
        scale * np.diff(tangential) * (INSTANTS - 1),
        period=1.0,
    )
    return noise, noise / math.sqrt(float(rate @ rate)), noise / math.sqrt(float(apart @ apart))
