"""The loads of a path; where its increments end: turning points, regular instants; where it leaves
the admissible region.

The loads are P and Q; where a path has bulk stress or tilt they are five: P, Q, sigma_lower,
sigma_upper, and tilt or moment.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from halfplane_fe.arrays import Array
from scenes import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
    Combination,
    InadmissibleLoadError,
    LoadPath,
    LoadSegment,
    sampled,
)

# Samples a leg, at least, on which a sign change of a rate is looked for; a turning point and its
# twin closer than that are missed together.
_SAMPLES = 721
# Share of the largest load below which a load can't be told from none: the nodal forces are known
# to about so much of it.
_LEAST_LOAD = 1e-12
# Share of f times the largest load within which |Q| is f P.
_ROUNDING_OF_LIMIT = 1e-14
_LITTLE_LOAD = (
    "so little load, 1e-12 of the largest or less, finite elements can't tell from separation; the"
    " half-plane engine can"
)
_UNLOADED = (
    "finite elements need P > 0 after the start, for unloaded bodies have no place; half-plane"
    " theory takes full unloading, P = Q = 0: keep P > 0, or solve the scene by theory alone"
)
_SLIDING = (
    "finite elements need |Q| below f P (half-plane theory takes |Q| = f P too); lower the"
    " tangential load, raise the normal load or friction.coefficient"
)


@dataclass(frozen=True)
class Stretch:
    """A piece of a leg between turning points, with the instants at which regular increments
    end.
    """

    leg: LoadSegment
    start: float
    ends: tuple[float, ...]


def has_bulk_stress(path: LoadPath) -> bool:
    """Whether a body of the path has a bulk stress, be it 0 at times."""
    return path.initial_loading[0].bulk is not None


def turned(path: LoadPath) -> bool:
    """Whether the upper body is tilted, by an angle or a moment."""
    return path.initial_loading[0].turning is not None


def _parts(leg: LoadSegment) -> tuple[tuple[LoadSegment | None, Combination], ...]:
    """The loads of a leg: each a combination of a segment's pair, or 0."""
    pair = (leg, NORMAL_LOAD), (leg, TANGENTIAL_LOAD)
    if leg.bulk is None and leg.turning is None:
        return pair
    # Of tilt and moment one is 0 throughout.
    return (
        *pair,
        (leg.bulk, NORMAL_LOAD),
        (leg.bulk, TANGENTIAL_LOAD),
        (leg.turning, Combination(1.0, 1.0)),
    )


def straight(leg: LoadSegment) -> bool:
    """Whether all loads of a leg are linear in time."""
    return all(segment is None or segment.is_straight for segment, _ in _parts(leg))


def loads_of(leg: LoadSegment, time: float) -> tuple[float, ...]:
    """The two or five loads of a leg at an instant."""
    p, q = leg.loads(time)
    if leg.bulk is None and leg.turning is None:
        return float(p), float(q)

    def load(segment: LoadSegment | None, what: Combination) -> float:
        return (
            0.0
            if segment is None
            else sum(c * float(one) for c, one in zip(what, segment.loads(time), strict=True))
        )

    return float(p), float(q), *(load(*part) for part in _parts(leg)[2:])


def scaled_loads(leg: LoadSegment, time: float, units: tuple[float, ...]) -> tuple[float, ...]:
    """The same, each over its unit; there may be more units than loads."""
    return tuple(load / unit for load, unit in zip(loads_of(leg, time), units, strict=False))


def turns(leg: LoadSegment, normal: float, tangential: float) -> set[float]:
    """Instants inside a leg at which normal P + tangential Q turns round."""
    times = sampled(leg, _SAMPLES)

    def rate(t: Array | float) -> Array:
        p, q = leg.rates(t)
        return np.asarray(normal * p + tangential * q)

    rates = rate(times)
    rates[np.abs(rates) < 1e-12 * np.abs(rates).max(initial=0.0)] = 0.0
    inner = np.flatnonzero(rates[:-1] * rates[1:] < 0)
    found = {
        float(brentq(lambda t: float(rate(t)), times[k], times[k + 1], xtol=1e-14)) for k in inner
    }
    touches = 1 + np.flatnonzero((rates[1:-1] == 0) & ((rates[:-2] != 0) | (rates[2:] != 0)))
    return found | {float(times[k]) for k in touches}


def turning_points(leg: LoadSegment, friction: float) -> list[float]:
    """Instants inside a leg at which P, Q - f P, Q + f P, a bulk stress, tilt or moment turn round,
    ascending.
    """
    found = turns(leg, 1.0, 0.0) | turns(leg, -friction, 1.0) | turns(leg, friction, 1.0)
    for segment, what in _parts(leg)[2:]:
        found |= set() if segment is None else turns(segment, *what)
    span = leg.end - leg.start
    ordered: list[float] = []
    for time in sorted(found):
        apart = time - (ordered[-1] if ordered else leg.start)
        if min(apart, leg.end - time) > 1e-9 * span:
            ordered.append(time)
    return ordered


def stretches(leg: LoadSegment, friction: float, increments: float) -> list[Stretch]:
    """A leg cut at its turning points, each piece into equal increments, `increments` of them in
    all (rounded up).
    """
    corners = [leg.start, *turning_points(leg, friction), leg.end]
    pieces = []
    for start, end in itertools.pairwise(corners):
        n = max(2, int(np.ceil(increments * (end - start) / (leg.end - leg.start))))
        pieces.append(Stretch(leg, start, tuple(np.linspace(start, end, n + 1)[1:])))
    return pieces


# Gauss points on an increment: the rest of an ellipse's area is below round-off from 24 increments
# a revolution on.
_GAUSS = np.polynomial.legendre.leggauss(8)


def enclosed(leg: LoadSegment, times: Array) -> Array | None:
    """(k, k, m) integral of load i d load j along the leg between m + 1 times, minus that along the
    chords; None of a straight leg.

    It is skew: the integral of d(i j) is the same along both.
    """
    if straight(leg):
        return None
    parts, start, end = _parts(leg), times[:-1, None], times[1:, None]
    inside, share = (start + end) / 2 + (end - start) / 2 * _GAUSS[0], _GAUSS[1] * (end - start) / 2
    found = np.zeros((len(parts), len(parts), len(start)))
    for i, (segment, what) in enumerate(parts):
        if segment is not None:
            above = segment.change_of(what, inside, start) - segment.change_of(what, end, start) / 2
            for j, (other, along) in enumerate(parts[:i]):
                if other is not None:
                    found[i, j] = (share * above * other.rate_of(along, inside)).sum(axis=1)
                    found[j, i] = -found[i, j]
    return found


def check_admissible(path: LoadPath, friction: float) -> None:
    """Refuse a path with separation or gross sliding (|Q| >= f P, with Q = 0 allowed).

    Separation is P <= 0 after the start, or so little load that it can't be told from none.
    Both extremes are met at turning points, so looking there is exact: to 1e-14 of f times the
    largest load, in any unit and for any f. The half-plane engine admits |Q| = f P itself; here
    nothing sticks then, and the tangential displacement has no value.

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
            if max(abs(p[worst]), abs(q[worst])) <= _ROUNDING_OF_LIMIT * scale:
                rule = _UNLOADED
            raise InadmissibleLoadError(
                "separation", times[worst], p[worst], q[worst], friction, rule=rule
            )
        excess = np.abs(q) - friction * p
        sliding = inside & (excess >= -_ROUNDING_OF_LIMIT * friction * scale) & (q != 0)
        if sliding.any():
            worst = int(np.argmax(np.where(sliding, excess, -np.inf)))
            raise InadmissibleLoadError(
                "gross sliding", times[worst], p[worst], q[worst], friction, rule=_SLIDING
            )
