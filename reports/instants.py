"""Which instants of a cycle are worth a picture: where a load turns, and where the slip does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
    while len(chosen) < min(count, len(cycle.time) - 1):
        chosen.setdefault(_widest_gap(chosen, len(cycle.time)), "between")
    return tuple(Event(index, chosen[index]) for index in sorted(chosen))


def _first_largest(quantity: np.ndarray, size: float) -> int:
    """The first instant at which `quantity` is largest, to rounding: the end of a cycle repeats its start."""
    return int(np.flatnonzero(quantity >= np.max(quantity) - 1e-12 * size)[0])


def _widest_gap(chosen: dict[int, str], length: int) -> int:
    """The middle of the widest gap between the chosen indices, the ends of the cycle counting as chosen."""
    stops = sorted({-1, *chosen, length})
    widest = max(range(len(stops) - 1), key=lambda k: stops[k + 1] - stops[k])
    return (stops[widest] + stops[widest + 1]) // 2
