"""Which instants of a cycle are worth a picture: where a load turns, and where the slip does."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.sampling import Cycle


@dataclass(frozen=True)
class Event:
    """An instant of the last cycle: its index in the cycle and what happens there."""

    index: int
    label: str


def events(cycle: Cycle, friction: float, count: int = 6) -> tuple[Event, ...]:
    """At most `count` instants in the order of time: extremes of P, Q, Q - f P, Q + f P; then middles of gaps.

    Q - f P is largest where forward slip ends, Q + f P least where reverse slip ends. A quantity that does not move has
    no extremes.
    """
    normal, tangential = cycle.normal_load, cycle.tangential_load
    wanted = (
        ("P largest", normal),
        ("P least", -normal),
        ("Q largest", tangential),
        ("Q least", -tangential),
        ("forward slip ends", tangential - friction * normal),
        ("reverse slip ends", -tangential - friction * normal),
    )
    found: dict[int, str] = {}
    size = float(np.max(np.abs(normal)))
    for label, quantity in wanted:
        if np.ptp(quantity) > 1e-9 * size:
            found.setdefault(_first_largest(quantity, size), label)
    chosen = dict(list(found.items())[:count])
    if len(cycle.time) == 1:
        chosen = {0: "the only instant"}
    while len(chosen) < min(count, len(cycle.time) - 1):
        chosen.setdefault(_widest_gap(chosen, cycle.time), "between")
    return tuple(Event(index, chosen[index]) for index in sorted(chosen))


def _first_largest(quantity: np.ndarray, size: float) -> int:
    """The first instant at which `quantity` is largest, to rounding: the end of a cycle repeats its start."""
    return int(np.flatnonzero(quantity >= np.max(quantity) - 1e-12 * size)[0])


def _widest_gap(chosen: dict[int, str], time: NDArray[np.float64]) -> int:
    """The instant nearest to the middle of the longest time between chosen ones, the ends of the cycle counting as such."""
    last = len(time) - 1
    stops = sorted({-1, *chosen, last + 1})  # the ends themselves may be chosen too
    gaps = [(time[max(a, 0)], time[min(b, last)], np.arange(a + 1, b)) for a, b in itertools.pairwise(stops) if b - a > 1]
    start, end, inside = max(gaps, key=lambda gap: gap[1] - gap[0])
    return int(inside[np.argmin(np.abs(time[inside] - (start + end) / 2))])
