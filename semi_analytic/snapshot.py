"""The memory curves of many instants side by side, as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semi_analytic.history import Span
from semi_analytic.memory import Curve, Piece

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Each instant's curve is `actives[which]` up to the load `load - slipped`, and from there a line of slope `direction` f.

    Attributes
    ----------
    time : (n,) times of the spans' legs
    load, force : (n,) P and Q
    slipped : (n,) P - P_c
    direction : (n,) +1, -1 or 0
    which : (n,) number of the uppermost piece among `actives`
    actives : the different pieces (None: the front is at P_c = 0)
    friction : f
    """

    time: Array
    load: Array
    force: Array
    slipped: Array
    direction: NDArray[np.int64]
    which: Indices
    actives: tuple[Curve, ...]
    friction: float

    def groups(self) -> Iterator[tuple[Piece, Indices]]:
        """(piece, its instants) for every piece that is there."""
        order = np.argsort(self.which, kind="stable")
        numbers, starts = np.unique(self.which[order], return_index=True)
        for number, here in zip(numbers, np.split(order, starts[1:]), strict=True):
            piece = self.actives[number]
            if piece is not None:
                yield piece, here


def take(parts: Iterable[tuple[Span, Array]]) -> Snapshot:
    """The snapshot of spans at times (k,) of their legs, one after the other."""
    times, loads, forces, slips, directions, counts = [], [], [], [], [], []
    actives: list[Curve] = []
    friction = 0.0
    for span, time in parts:
        load, force = span.leg.loads(time)
        load = np.maximum(load, 0.0)  # a path that unloads fully may end below 0 by rounding
        times.append(time)
        loads.append(load)
        forces.append(force)
        slips.append(span.slipped_at(time, load))
        directions.append(span.direction)
        counts.append(len(time))
        actives.append(span.active)
        friction = span.friction
    return Snapshot(
        time=np.concatenate(times),
        load=np.concatenate(loads),
        force=np.concatenate(forces),
        slipped=np.concatenate(slips),
        direction=np.repeat(np.array(directions), counts),
        which=np.repeat(np.arange(len(actives)), counts),
        actives=tuple(actives),
        friction=friction,
    )
