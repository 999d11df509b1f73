"""Where the increments of a load path end: turning points, regular instants; and where the path leaves the admissible region."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from scenes import NORMAL_LOAD, TANGENTIAL_LOAD, InadmissibleLoadError, LoadPath, LoadSegment, sampled

Array = NDArray[np.float64]

# Samples a leg, at least, on which a sign change of a rate is looked for; a turning point and its twin closer than that are
# missed together.
_SAMPLES = 721
# Share of the largest load below which a load can't be told from none: the nodal forces are known to about so much of it.
_LEAST_LOAD = 1e-12
# Share of f times the largest load within which |Q| is f P.
_ROUNDING_OF_LIMIT = 1e-14
_LITTLE_LOAD = "so little load, 1e-12 of the largest or less, finite elements can't tell from separation; the half-plane engine can"
_SLIDING = (
    "finite elements need |Q| below f P (half-plane theory takes |Q| = f P too); lower the tangential load, raise the normal load "
    "or friction.coefficient"
)


@dataclass(frozen=True)
class Stretch:
    """A piece of a leg between turning points, with the instants at which regular increments end."""

    leg: LoadSegment
    start: float
    ends: tuple[float, ...]


def turns(leg: LoadSegment, normal: float, tangential: float) -> set[float]:
    """Instants inside a leg at which normal P + tangential Q turns round."""
    times = sampled(leg, _SAMPLES)

    def rate(t: Array | float) -> Array:
        p, q = leg.rates(t)
        return np.asarray(normal * p + tangential * q)

    rates = rate(times)
    rates[np.abs(rates) < 1e-12 * np.abs(rates).max(initial=0.0)] = 0.0
    inner = np.flatnonzero(rates[:-1] * rates[1:] < 0)
    found = {float(brentq(lambda t: float(rate(t)), times[k], times[k + 1], xtol=1e-14)) for k in inner}
    touches = 1 + np.flatnonzero((rates[1:-1] == 0) & ((rates[:-2] != 0) | (rates[2:] != 0)))
    return found | {float(times[k]) for k in touches}


def turning_points(leg: LoadSegment, friction: float) -> list[float]:
    """Instants inside a leg at which P, Q - f P or Q + f P turn round, ascending."""
    found = turns(leg, 1.0, 0.0) | turns(leg, -friction, 1.0) | turns(leg, friction, 1.0)
    span = leg.end - leg.start
    ordered: list[float] = []
    for time in sorted(found):
        apart = time - (ordered[-1] if ordered else leg.start)
        if min(apart, leg.end - time) > 1e-9 * span:
            ordered.append(time)
    return ordered


def stretches(leg: LoadSegment, friction: float, increments: float) -> list[Stretch]:
    """A leg cut at its turning points, each piece into equal increments, `increments` of them in all (rounded up)."""
    corners = [leg.start, *turning_points(leg, friction), leg.end]
    pieces = []
    for start, end in itertools.pairwise(corners):
        n = max(2, int(np.ceil(increments * (end - start) / (leg.end - leg.start))))
        pieces.append(Stretch(leg, start, tuple(np.linspace(start, end, n + 1)[1:])))
    return pieces


# Gauss points on an increment: the rest of an ellipse's area is below round-off from 24 increments a revolution on.
_GAUSS = np.polynomial.legendre.leggauss(8)


def enclosed(leg: LoadSegment, start: float, end: float) -> float:
    """Integral of Q dP along the leg from start to end, minus that along the chord: 0 of a straight leg."""
    if leg.is_straight:
        return 0.0
    times = (start + end) / 2 + (end - start) / 2 * _GAUSS[0]
    rise = float(leg.change_of(TANGENTIAL_LOAD, end, start))
    above = leg.change_of(TANGENTIAL_LOAD, times, start) - rise / 2
    return float(np.sum(_GAUSS[1] * above * leg.rate_of(NORMAL_LOAD, times))) * (end - start) / 2


def check_admissible(path: LoadPath, friction: float) -> None:
    """Refuse a path with separation or gross sliding (|Q| >= f P, with Q = 0 allowed).

    Separation is P <= 0 after the start, or so little load that it can't be told from none.
    Both extremes are met at turning points, so looking there is exact: to 1e-14 of f times the largest load, in any unit and for
    any f. The half-plane engine admits |Q| = f P itself; here nothing sticks then, and the tangential displacement has no value.

    Raises
    ------
    InadmissibleLoadError
        At the worst instant of the first leg at fault.
    """
    for leg in path.legs(1):
        times = np.array([leg.start, *turning_points(leg, friction), leg.end])
        p, q = leg.loads(times)
        inside = times > path.start
        scale = float(np.abs(p).max())
        separated = inside & (p <= _LEAST_LOAD * scale)
        if separated.any():
            worst = int(np.argmin(np.where(separated, p, np.inf)))
            rule = _LITTLE_LOAD if p[worst] > 0 else ""
            raise InadmissibleLoadError("separation", times[worst], p[worst], q[worst], friction, rule=rule)
        excess = np.abs(q) - friction * p
        sliding = inside & (excess >= -_ROUNDING_OF_LIMIT * friction * scale) & (q != 0)
        if sliding.any():
            worst = int(np.argmax(np.where(sliding, excess, -np.inf)))
            raise InadmissibleLoadError("gross sliding", times[worst], p[worst], q[worst], friction, rule=_SLIDING)
