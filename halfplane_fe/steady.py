"""Shakedown and ratcheting: where a series of one value a revolution goes, and how far from there its last value is.

With P and Q on like bodies the second revolution repeats the first. Unlike bodies only approach their steady state, and so do loops
with bulk stress or tilt out of phase: geometrically, or as a power of the number k of revolutions. Then a small last change d_k is
no bound of what is left:

    geometric, d_k/d_(k-1) = r:             left = d_k r/(1 - r)
    algebraic, left in proportion to k^-m:     left = d_k/[(k/(k-1))^m - 1], about (k/m) d_k

The number m follows from the last ratio, d_k being about (k - 1/2)^-(m+1): r = ((k - 3/2)/(k - 1/2))^(m+1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# Share of the largest value within which two values are the same but for round-off.
_ROUNDING = 1e-12
# A ratio of a geometric series stays; that of m = 1 rises by a factor of 1 + 2/[k (k-2)] from one revolution to the next. Half-way
# between the two a series counts as algebraic.
_RISES = 1.0
# Steep ends of series look steeper than they are: k^-3 is the steepest seen. Slower than k^-1/2 is no trend.
_STEEPEST, _SLOWEST = 3.0, 0.5
# Drifts that vanish leave as much as themselves, to the trend's own error; those of ratcheting next to nothing.
_DRIFT, _FAR = 1e-3, 3.0


@dataclass(frozen=True)
class Trend:
    """What is left of a series after its last value.

    Attributes
    ----------
    kind : "steady" (the last two values are the same to round-off), "geometric", "algebraic", or "unclear": fewer than four values,
        or differences that do not fall
    left : limit minus the last value; of an unclear one k |d_k|, which is a size without a sign, or NaN of a single value
    limit : of the series, NaN of an unclear one
    """

    kind: str
    left: float
    limit: float


def trend(values: Sequence[float]) -> Trend:
    """The trend of a series by its last four values, one a revolution from the first one on.

    >>> trend([5.0, 3.0, 2.5, 2.375]).kind, trend([1.5, 1.25, 1.125, 1.0625])
    ('geometric', Trend(kind='geometric', left=-0.0625, limit=1.0))
    """
    k, apart = len(values), np.diff(values).tolist()
    if k < 2:
        return Trend("unclear", float("nan"), float("nan"))
    last = apart[-1]
    if k * abs(last) <= _ROUNDING * max(map(abs, values)):
        return Trend("steady", 0.0, values[-1])
    unclear = Trend("unclear", k * abs(last), float("nan"))
    if k < 4 or not all(apart[-3:]):
        return unclear
    before, ratio = apart[-2] / apart[-3], apart[-1] / apart[-2]
    if not (0 < before < 1 and 0 < ratio < 1):
        return unclear
    if ratio <= before * (1 + _RISES / (k * (k - 2))):
        left = last * ratio / (1 - ratio)
        return Trend("geometric", left, values[-1] + left)
    power = min(float(np.log(ratio) / np.log((k - 1.5) / (k - 0.5))) - 1, _STEEPEST)
    if power < _SLOWEST:
        return unclear
    left = last / ((k / (k - 1)) ** power - 1)
    return Trend("algebraic", left, values[-1] + left)


def ratchets(drifts: Sequence[float], travel: float) -> bool:
    """Whether U goes on drifting: the last of its changes from start to end of each revolution is no step on a way to zero.

    Parameters
    ----------
    drifts : one a revolution
    travel : largest minus smallest U of the last revolution; a thousandth of it is no drift

    >>> ratchets([0.3, 0.11, 0.1, 0.1], 1.0), ratchets([0.4, 0.2, 0.1, 0.05], 1.0)
    (True, False)
    """
    last = abs(drifts[-1])
    return last > _DRIFT * travel and last > _FAR * abs(trend(drifts).left)
