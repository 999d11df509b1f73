"""On which side of the memory curve a path runs that unloads it: above, below or along the curve, and where it crosses."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import Leg
from semi_analytic.legs import NORMAL_LOAD, Combination, Instant, change, change_from, stationary, time_of
from semi_analytic.memory import Curve, Piece, pieces, value_on

Array = NDArray[np.float64]

# Share of f P + |Q| within which the path runs along the curve.
_ROUNDING = 1e-14
# Instants at which a piece without a formula for its crossings is looked at.
_SAMPLES = 33


def sides(curve: Curve, first: Instant, last: Instant, friction: float) -> list[tuple[float, float, int]]:
    """(begin, end, direction) where the path runs above (+1), below (-1) or along (0) the curve that it unloads."""
    runs: list[tuple[float, float, int]] = []
    begin = first.time
    for piece in pieces(curve):
        drop = piece.bottom - first.normal
        reached = float(change(first.leg, NORMAL_LOAD, last.time, first.time)) < drop
        end = float(time_of(first.leg, NORMAL_LOAD, drop, first.time, last.time)) if reached else last.time
        if end > begin:
            runs += _sides_on(piece, first.leg, begin, end, friction)
        begin = max(begin, end)
        if not reached:
            break
    merged: list[tuple[float, float, int]] = []
    for run in runs:
        if merged and merged[-1][2] == run[2]:
            merged[-1] = (merged[-1][0], run[1], run[2])
        else:
            merged.append(run)
    return merged


def _sides_on(piece: Piece, leg: Leg, begin: float, end: float, friction: float) -> list[tuple[float, float, int]]:
    """The same while the load is within one piece: signs of Q - M(P) between its roots."""

    def excess(time: ArrayLike) -> Array:
        if piece.arc is None and piece.bend == 0:
            return change_from(piece.anchor, leg, Combination(-piece.slope, 1.0), time)
        normal, tangential = leg.loads(time)
        return tangential - value_on(piece, np.clip(normal, piece.bottom, piece.anchor.normal))

    turning = stationary(leg, Combination(-piece.slope, 1.0)) if piece.arc is None else []
    count = 3 if piece.arc is None and piece.bend == 0 else _SAMPLES
    times = np.unique([*np.linspace(begin, end, count), *(time for time in turning if begin < time < end)])
    noise = _ROUNDING * (friction * piece.anchor.normal + abs(piece.anchor.tangential))
    above = excess(times)
    signs = np.where(np.abs(above) <= noise, 0, np.sign(above)).astype(int)
    if not np.any(signs):
        return [(begin, end, 0)]
    known = np.flatnonzero(signs)
    marks, directions = [begin], [int(signs[known[0]])]
    for left, right in pairwise(known):
        if signs[left] != signs[right]:
            marks.append(_root(excess, float(times[left]), float(times[right])))
            directions.append(int(signs[right]))
    return list(zip(marks, [*marks[1:], end], directions, strict=True))


def _root(function: Callable[[ArrayLike], Array], low: float, high: float) -> float:
    """Bisection to the last digit."""
    sign = np.sign(function(low))
    while True:
        middle = (low + high) / 2
        if not low < middle < high:
            return middle
        if np.sign(function(middle)) == sign:
            low = middle
        else:
            high = middle
