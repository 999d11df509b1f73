"""Linear combinations of P and Q along a load segment: the segments' own methods as functions, and instants of the path.

The load itself is (1, 0); u = Q - f P, which grows in forward slip, is (-f, 1); -v = -Q - f P, which grows in reverse slip,
(-f, -1).
"""

from __future__ import annotations

import cmath
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import NORMAL_LOAD, Combination, HarmonicSegment, LoadSegment
from scenes.segments import LEAST

Array = NDArray[np.float64]

__all__ = [
    "LEAST",
    "NORMAL_LOAD",
    "Combination",
    "Instant",
    "change",
    "change_from",
    "instant",
    "level",
    "mirrored",
    "phasor",
    "rate",
    "stationary",
    "stretches",
    "time_of",
]

# Share of the times of a segment within which two of its turning points are one.
_ROUNDING = 1e-14


def level(direction: int, friction: float) -> Combination:
    """The combination that grows while the surfaces slip in `direction` (+1 forward, -1 reverse): +-Q - f P."""
    return Combination(-friction, float(direction))


class Instant(NamedTuple):
    """A point of the load path: segment, the segment's own time, and both loads there."""

    leg: LoadSegment
    time: float
    normal: float
    tangential: float


def instant(leg: LoadSegment, time: float) -> Instant:
    """The point of `leg` at `time`."""
    normal, tangential = leg.loads(time)
    return Instant(leg, float(time), float(normal), float(tangential))


def phasor(leg: LoadSegment, what: Combination) -> complex:
    """Z such that c_P P + c_Q Q = constant + Re[Z exp(i t)] of an ellipse."""
    assert isinstance(leg, HarmonicSegment)
    return cmath.rect(*leg.wave(what))


def change(leg: LoadSegment, what: Combination, time: ArrayLike, since: ArrayLike) -> Array:
    """Change of the combination between two times of one segment."""
    return leg.change_of(what, time, since)


def change_from(where: Instant, leg: LoadSegment, what: Combination, time: ArrayLike) -> Array:
    """Change of the combination from any earlier instant of the path to `time` on `leg`."""
    if where.leg is leg:
        return leg.change_of(what, time, where.time)
    begin = instant(leg, leg.start)
    jump = what.normal * (begin.normal - where.normal) + what.tangential * (begin.tangential - where.tangential)
    return leg.change_of(what, time, leg.start) + jump


def rate(leg: LoadSegment, what: Combination, time: ArrayLike) -> Array:
    """Time derivative of the combination."""
    return leg.rate_of(what, time)


def stationary(leg: LoadSegment, what: Combination) -> list[float]:
    """Times inside the segment at which the combination stops growing or falling, ascending."""
    return leg.turning_points(what)


def time_of(leg: LoadSegment, what: Combination, amount: ArrayLike, begin: float, end: float) -> Array:
    """The time between `begin` and `end` at which the combination has changed by `amount` since `begin`."""
    return leg.time_of(what, amount, begin, end)


def mirrored(leg: LoadSegment, what: Combination, time: ArrayLike, near: float) -> Array:
    """The other time, next to `near`, at which the combination on an ellipse has the value that it has at `time`."""
    twin = leg.mirrored(what, time, near)
    assert twin is not None
    return twin


def stretches(leg: LoadSegment, friction: float) -> list[tuple[float, float]]:
    """The segment, cut where P, u = Q - f P or v = Q + f P turn round.

    >>> from math import pi
    >>> from scenes import ellipse_segment
    >>> circle = ellipse_segment(0.0, 2 * pi, (3.0, 0.0), (1.0, 1.0), pi / 2)
    >>> [round(begin / pi, 2) for begin, _ in stretches(circle, 1.0)]
    [0.0, 0.25, 0.75, 1.0, 1.25, 1.75]
    """
    combinations = (NORMAL_LOAD, level(1, friction), level(-1, friction))
    inside = sorted(time for what in combinations for time in leg.turning_points(what))
    shortest = _ROUNDING * max(abs(leg.start), abs(leg.end), leg.end - leg.start)
    marks = [leg.start]
    for time in inside:
        if time - marks[-1] > shortest and leg.end - time > shortest:
            marks.append(time)
    return list(zip(marks, [*marks[1:], leg.end], strict=True))
