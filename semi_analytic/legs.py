"""Linear combinations c_P P + c_Q Q along a leg of the load path: changes without cancellation, turning points, inverses.

The load itself is (1, 0); u = Q - f P, which grows in forward slip, is (-f, 1); -v = -Q - f P, which grows in reverse slip,
(-f, -1).
"""

from __future__ import annotations

import cmath
import math
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from scenes import ChebyshevLeg, EllipseLeg, HarmonicLeg, Leg, NotFoundError, ParabolaLeg, StraightLeg
from semi_analytic.turning import LEAST, stationary_on_harmonics, stationary_on_series

Array = NDArray[np.float64]

_SAMPLES = 257
_ROUNDING = 1e-14
_IDLE, _SHORT = 3, 1e-9
_ROUNDING_OF_TIME = 4.5e-16
# Steps of Newton's method with a bracket: some 60 halve the bracket to rounding, and some 60 the step between two of these.
_MOST_STEPS = 4000


class Combination(NamedTuple):
    """c_P P + c_Q Q of the two loads."""

    normal: float
    tangential: float


NORMAL_LOAD = Combination(1.0, 0.0)


def level(direction: int, friction: float) -> Combination:
    """The combination that grows while the surfaces slip in `direction` (+1 forward, -1 reverse): +-Q - f P."""
    return Combination(-friction, float(direction))


class Instant(NamedTuple):
    """A point of the load path: leg, the leg's own time, and both loads there."""

    leg: Leg
    time: float
    normal: float
    tangential: float


def instant(leg: Leg, time: float) -> Instant:
    """The point of `leg` at `time`."""
    if isinstance(leg, StraightLeg) and time in (leg.start, leg.end):
        return Instant(leg, float(time), *(leg.first if time == leg.start else leg.last))
    normal, tangential = leg.loads(time)
    return Instant(leg, float(time), float(normal), float(tangential))


def phasor(leg: EllipseLeg, what: Combination) -> complex:
    """Z such that c_P P + c_Q Q = constant + Re[Z exp(i t)]."""
    return what.tangential * leg.amplitude[1] * cmath.exp(-1j * leg.phase) + what.normal * leg.amplitude[0]


def change(leg: Leg, what: Combination, time: ArrayLike, since: ArrayLike) -> Array:
    """Change of the combination between two times of one leg; near an extremum of an ellipse to full relative accuracy too.

    >>> leg = EllipseLeg(0.0, 7.0, (3.0, 1.0), (1.0, 1.0), math.pi / 2)
    >>> float(change(leg, NORMAL_LOAD, math.pi, 0.0))
    -2.0
    """
    if isinstance(leg, EllipseLeg):
        amplitude = phasor(leg, what)
        t, t0 = np.asarray(time, dtype=float), np.asarray(since, dtype=float)
        middle = (t + t0) / 2 + cmath.phase(amplitude)
        return -2 * abs(amplitude) * np.sin(middle) * np.sin((t - t0) / 2)
    normal, tangential = leg.change(time, since)
    return what.normal * normal + what.tangential * tangential


def change_from(where: Instant, leg: Leg, what: Combination, time: ArrayLike) -> Array:
    """Change of the combination from any earlier instant of the path to `time` on `leg`."""
    if where.leg is leg:
        return change(leg, what, time, where.time)
    begin = instant(leg, leg.start)
    jump = what.normal * (begin.normal - where.normal) + what.tangential * (begin.tangential - where.tangential)
    return change(leg, what, time, leg.start) + jump


def rate(leg: Leg, what: Combination, time: ArrayLike) -> Array:
    """Time derivative of the combination."""
    if isinstance(leg, EllipseLeg):
        amplitude = phasor(leg, what)
        return -abs(amplitude) * np.sin(np.asarray(time, dtype=float) + cmath.phase(amplitude))
    normal, tangential = leg.rates(time)
    return what.normal * normal + what.tangential * tangential


def stationary(leg: Leg, what: Combination) -> list[float]:
    """Times inside the leg at which the combination stops growing or falling, ascending."""
    if isinstance(leg, StraightLeg):
        return []
    if isinstance(leg, ParabolaLeg):
        return _stationary_on_parabola(leg, what)
    if isinstance(leg, EllipseLeg):
        return _stationary_on_ellipse(leg, what)
    if isinstance(leg, HarmonicLeg):
        return stationary_on_harmonics(leg, what.normal, what.tangential)
    if isinstance(leg, ChebyshevLeg):
        return stationary_on_series(leg, what.normal, what.tangential)
    return _stationary_sampled(leg, what)


def _stationary_on_ellipse(leg: EllipseLeg, what: Combination) -> list[float]:
    amplitude = phasor(leg, what)
    size = abs(what.normal) * leg.amplitude[0] + abs(what.tangential) * leg.amplitude[1]
    if abs(amplitude) <= _ROUNDING * size:
        return []
    first = -cmath.phase(amplitude)
    lowest = math.ceil((leg.start - first) / math.pi)
    highest = math.floor((leg.end - first) / math.pi)
    times = (first + k * math.pi for k in range(lowest, highest + 1))
    return [time for time in times if leg.start < time < leg.end]


def _stationary_on_parabola(leg: ParabolaLeg, what: Combination) -> list[float]:
    alpha, beta = leg.coefficients
    bend = 2 * what.tangential * beta * leg.last[0]
    if bend == 0:
        return []
    time = leg.start - (what.normal + what.tangential * alpha) / bend * (leg.end - leg.start)
    return [time] if leg.start < time < leg.end else []


def _stationary_sampled(leg: Leg, what: Combination) -> list[float]:
    """Sign changes of the rate between samples, then bracketed to rounding: for legs without a formula."""
    times = np.linspace(leg.start, leg.end, _SAMPLES)
    rates = rate(leg, what, times)
    brackets = ((times[k], times[k + 1]) for k in np.flatnonzero(rates[:-1] * rates[1:] < 0))
    roots = [scipy.optimize.brentq(lambda t: float(rate(leg, what, t)), *pair, xtol=_ROUNDING_OF_TIME) for pair in brackets]
    return sorted(float(time) for time in [*times[1:-1][rates[1:-1] == 0], *roots])


def time_of(leg: Leg, what: Combination, amount: ArrayLike, begin: float, end: float) -> Array:
    """The time between `begin` and `end` at which a combination that does not turn there has changed by `amount` since `begin`.

    Amounts outside the range give the nearer end. `begin` may be the later one: the time is best known near it.
    """
    wanted = np.asarray(amount, dtype=float)
    total = float(change(leg, what, end, begin))
    if abs(total) < LEAST:
        return np.full(wanted.shape, begin)
    sign = math.copysign(1.0, total)
    if isinstance(leg, StraightLeg):
        inside = begin + (end - begin) * (wanted / total)
    elif isinstance(leg, EllipseLeg):
        inside = _time_on_ellipse(leg, what, wanted, begin, end)
    else:
        inside = _time_by_newton(leg, what, np.clip(wanted / total, 0, 1) * total, total, begin, end)
    inside = np.clip(inside, min(begin, end), max(begin, end))
    return np.where(sign * wanted <= 0, begin, np.where(sign * wanted >= abs(total), end, inside))


def _time_on_ellipse(leg: EllipseLeg, what: Combination, wanted: Array, begin: float, end: float) -> Array:
    """Closed form by the arc cosine, then one Newton step with the change, which does not cancel."""
    amplitude = phasor(leg, what)
    size, angle = abs(amplitude), cmath.phase(amplitude)
    half_turn = math.floor(((begin + end) / 2 + angle) / math.pi)
    sign = -1.0 if half_turn % 2 else 1.0
    cosine = math.cos(begin + angle) + wanted / size
    time = half_turn * math.pi - angle + np.arccos(np.clip(sign * cosine, -1, 1))
    slope = rate(leg, what, time)
    fault = wanted - change(leg, what, time, begin)
    steep = np.abs(slope) > 1e-6 * size
    return time + np.where(steep, fault / np.where(steep, slope, 1.0), 0.0)


def mirrored(leg: EllipseLeg, what: Combination, time: ArrayLike, near: float) -> Array:
    """The other time, next to `near`, at which the combination has the value that it has at `time`."""
    t = np.asarray(time, dtype=float)
    twin = -2 * cmath.phase(phasor(leg, what)) - t
    return twin + 2 * math.pi * np.round((near - twin) / (2 * math.pi))


def _time_by_newton(leg: Leg, what: Combination, wanted: Array, total: float, begin: float, end: float) -> Array:
    """Newton's steps, or half the bracket where one leaves it or is no shorter; ends where rounding stops them from gaining."""
    rising = math.copysign(1.0, total) * math.copysign(1.0, end - begin)
    low, high = np.full(wanted.shape, min(begin, end)), np.full(wanted.shape, max(begin, end))
    time = begin + (end - begin) / math.pi * np.arccos(1 - 2 * wanted / total)  # exact for a cosine that turns at both ends
    best, least, idle, last = time, np.full(wanted.shape, math.inf), np.zeros(wanted.shape, int), high - low
    for _ in range(_MOST_STEPS):
        fault, slope = rising * (change(leg, what, time, begin) - wanted), rising * rate(leg, what, time)
        better = np.abs(fault) < least
        best, least, idle = np.where(better, time, best), np.where(better, np.abs(fault), least), np.where(better, 0, idle + 1)
        # Steps that gain no more are round-off where they are short: a long one is half a bracket, and others follow.
        no_gain = (idle >= _IDLE) & (last <= _SHORT * np.abs(best - begin))
        if np.all((least == 0) | no_gain | (last <= _ROUNDING_OF_TIME * np.abs(best))):
            return best
        low, high = np.where(fault < 0, time, low), np.where(fault > 0, time, high)
        steep = slope > 0
        newton = time - np.where(steep, fault / np.where(steep, slope, 1.0), math.inf)
        kept = (low <= newton) & (newton <= high) & (2 * np.abs(newton - time) <= last)
        following = np.where(kept, newton, (low + high) / 2)
        last, time = np.abs(following - time), following
    raise NotFoundError(f"no time was found at which the loads have changed as wanted, between {begin:.17g} and {end:.17g}")


def stretches(leg: Leg, friction: float) -> list[tuple[float, float]]:
    """The leg, cut where P, u = Q - f P or v = Q + f P turn round.

    >>> circle = EllipseLeg(0.0, 2 * math.pi, (3.0, 0.0), (1.0, 1.0), math.pi / 2)
    >>> [round(begin / math.pi, 2) for begin, _ in stretches(circle, 1.0)]
    [0.0, 0.25, 0.75, 1.0, 1.25, 1.75]
    """
    combinations = (NORMAL_LOAD, level(1, friction), level(-1, friction))
    inside = sorted(time for what in combinations for time in stationary(leg, what))
    shortest = _ROUNDING * max(abs(leg.start), abs(leg.end), leg.end - leg.start)
    marks = [leg.start]
    for time in inside:
        if time - marks[-1] > shortest and leg.end - time > shortest:
            marks.append(time)
    return list(zip(marks, [*marks[1:], leg.end], strict=True))
