"""Integrals over ranges in halves, and these in halves, until halving changes them no more; with what it changed last."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SETTLED = 1e-12
# How often a range is halved at most: parts of 1/131,072 of it are left as they are.
_HALVINGS = 17


class Settled(NamedTuple):
    """Integrals (m,), and an estimate of the error of each: what the last halving changed.

    Honest down to the floor of the rule: `graded` leaves 4e-12 of a part that has a pole beside its end, at whatever distance.
    """

    value: Array
    error: Array


def settled(work: Callable[[Indices, Array, Array], Array], begin: ArrayLike, end: ArrayLike, allowed: float) -> Settled:
    """Integrals of m integrands, number k from begin[k] to end[k].

    Parameters
    ----------
    work : work(which (n,), low (n,), high (n,)) gives the integral of integrand which[k] from low[k] to high[k], (n,), by one rule
    begin, end : (m,)
    allowed : the change at which a part is settled, `SETTLED` of their size where rounding leaves as much. A part of 2^-17 of its
        range, or one that is not finite, is left as it is, and its error shows that.

    >>> def midpoint(which, low, high):
    ...     return (high - low) * (low + high) / 2
    >>> settled(midpoint, [0.0, 1.0], [2.0, 3.0], SETTLED).value.tolist()
    [2.0, 4.0]
    """
    low, high = np.array(begin, dtype=float), np.array(end, dtype=float)
    which = np.arange(len(low))
    value, error = np.zeros(len(low)), np.zeros(len(low))
    rough = work(which, low, high)
    for turn in range(_HALVINGS + 1):
        middle = (low + high) / 2
        left, right = np.split(work(np.tile(which, 2), np.r_[low, middle], np.r_[middle, high]), 2)
        change = np.abs(left + right - rough)
        done = (change <= allowed) | ~np.isfinite(change) | (turn == _HALVINGS)
        np.add.at(value, which[done], (left + right)[done])
        np.add.at(error, which[done], change[done])
        on = ~done
        low, high = np.r_[low[on], middle[on]], np.r_[middle[on], high[on]]
        which, rough = np.tile(which[on], 2), np.r_[left[on], right[on]]
        if not len(which):
            break
    return Settled(value, error)
