"""Where a combination c_P P + c_Q Q of loads turns round on legs of several harmonics and of Chebyshev series, to rounding.

The rate is a polynomial in exp(i t) or in the time itself: all roots at once by eigenvalues, then steps of Newton on the rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import NDArray

from scenes import ChebyshevLeg, HarmonicLeg

Array = NDArray[np.float64]

LEAST = 1e-290
"""Changes of load below it are none: their inverse, and soon the numbers themselves, are not known to rounding any more."""

_ROUNDING = 1e-14
# A double root is known to the root of a rounding only. Taking too many does no harm: a stretch is cut in two.
_DOUBLE = 1e-5


def stationary_on_harmonics(leg: HarmonicLeg, normal: float, tangential: float) -> list[float]:
    """Times inside the leg at which the combination stops growing or falling, ascending.

    >>> leg = HarmonicLeg(0.0, 2 * math.pi, (3.0, 0.0), ((1.0, 0.0), (1.0, 0.0)), ())
    >>> [round(time / math.pi, 4) for time in stationary_on_harmonics(leg, 1.0, 0.0)]  # sin t (1 + 4 cos t) = 0
    [0.5804, 1.0, 1.4196]
    """
    count = max(len(leg.normal), len(leg.tangential))
    amplitude = np.zeros(count + 1, dtype=complex)
    size = np.zeros(count + 1)
    for factor, waves in ((normal, leg.normal), (tangential, leg.tangential)):
        for number, (length, phase) in enumerate(waves, 1):
            amplitude[number] += 1j * number * factor * length * np.exp(-1j * phase)
            size[number] += abs(number * factor * length)
    # The rate is Re of sum amplitude_k exp(i k t).
    whole = float(np.sum(size))
    if whole < LEAST:
        return []
    amplitude[np.abs(amplitude) <= _ROUNDING * whole] = 0
    known = np.flatnonzero(amplitude)
    if not len(known):
        return []
    order = known[-1]
    roots = polynomial.polyroots(np.concatenate([np.conj(amplitude[order:0:-1]), amplitude[: order + 1]]))
    angles = np.angle(roots[np.abs(np.abs(roots) - 1) < _DOUBLE])
    k = np.arange(order + 1)

    def rate(time: Array, derivative: int) -> Array:
        return np.real(np.exp(1j * time[:, None] * k) @ (amplitude[: order + 1] * (1j * k) ** derivative))

    first = 2 * math.pi * np.floor((leg.start - angles) / (2 * math.pi))
    turns = np.arange(math.ceil((leg.end - leg.start) / (2 * math.pi)) + 2)
    times = (angles + first)[:, None] + 2 * math.pi * turns
    return _inside(_polished(times.ravel(), rate), leg.start, leg.end)


def stationary_on_series(leg: ChebyshevLeg, normal: float, tangential: float) -> list[float]:
    """The same on a Chebyshev series of time.

    >>> leg = ChebyshevLeg(0.0, 4.0, (3.0, 0.0, 1.0), (0.0, 1.0))  # P = 2 + 2 (t/2 - 1)^2
    >>> stationary_on_series(leg, 1.0, 0.0)
    [2.0]
    """
    whole = np.zeros(max(len(leg.normal), len(leg.tangential)))
    whole[: len(leg.normal)] += normal * np.array(leg.normal)
    whole[: len(leg.tangential)] += tangential * np.array(leg.tangential)
    size = abs(normal) * np.max(np.abs(leg.normal)) + abs(tangential) * np.max(np.abs(leg.tangential))
    slope = chebyshev.chebder(whole)
    kept = np.flatnonzero(np.abs(slope) > _ROUNDING * size)
    if not len(kept):
        return []
    slope = slope[: kept[-1] + 1]
    roots = chebyshev.chebroots(slope) if len(slope) > 1 else np.empty(0)
    unit = np.clip(roots.real[(np.abs(roots.imag) < _DOUBLE) & (np.abs(roots.real) < 1 + _DOUBLE)], -1, 1)

    def rate(u: Array, derivative: int) -> Array:
        return np.asarray(chebyshev.chebval(u, chebyshev.chebder(slope, derivative) if derivative else slope))

    middle, half = (leg.start + leg.end) / 2, (leg.end - leg.start) / 2
    return _inside(middle + half * _polished(unit, rate), leg.start, leg.end)


def _polished(guess: Array, rate: Callable[[Array, int], Array]) -> Array:
    """Two of Newton's steps, as long as they are small."""
    found = guess
    for _ in range(2):
        slope = rate(found, 1)
        step = rate(found, 0) / np.where(slope != 0, slope, 1.0)
        found = found - np.where((slope != 0) & (np.abs(step) < _DOUBLE), step, 0.0)
    return found


def _inside(times: Array, start: float, end: float) -> list[float]:
    return sorted(float(time) for time in times if start < time < end)
