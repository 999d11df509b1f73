"""When two cycles change between full stick, partial slip and the two senses of slip, and how far those instants are apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.metrics import Array, shares
from reports.metrics_zones import stick_status
from reports.sampling import Cycle
from scenes import SLIP_FORWARD, SLIP_REVERSE

Mask = NDArray[np.bool_]
FULL_STICK = 2


@dataclass(frozen=True, eq=False)
class Changes:
    """Instants of the result less those of the reference that they belong to.

    Attributes
    ----------
    late : (m,) differences over the length of the cycle, positive where the result is late; NaN where the result has no
        counterpart
    index : (m,) instants of the reference as indices into the cycle
    missing, extra : how many instants of the one have no counterpart in the other
    """

    late: Array
    index: NDArray[np.intp]
    missing: int = 0
    extra: int = 0


def stretches(applies: Mask, periodic: bool) -> list[NDArray[np.intp]]:
    """The runs of at least two instants at which `applies` (k,), as indices in the order of time; none if it does always.

    In a periodic cycle, whose last instant is the first of the next, a run may go on across the end.

    >>> [run.tolist() for run in stretches(np.array([True, False, True, True, True]), True)]
    [[2, 3, 0]]
    >>> [run.tolist() for run in stretches(np.array([True, False, True, True]), False)]
    [[2, 3]]
    """
    order = np.arange(len(applies) - 1 if periodic else len(applies))
    if applies[order].all():
        return []
    if periodic:
        order = np.roll(order, -int(np.argmin(applies[order])))
    ordered = applies[order]
    runs = np.split(order, np.flatnonzero(np.diff(ordered)) + 1)
    return [run for run in runs if applies[run[0]] and len(run) >= 2]


def full_stick(reference: Cycle, result: Cycle, length: float, periodic: bool) -> tuple[Changes, Changes]:
    """Starts and ends of full stick: each stretch of the reference against the result's that shares most instants with it."""
    theirs, ours = (stretches(stick_status(cycle, length) == FULL_STICK, periodic) for cycle in (reference, result))
    pairs = [(run, max(ours, key=lambda other: len(np.intersect1d(run, other)), default=run[:0])) for run in theirs]
    pairs = [(run, other if len(np.intersect1d(run, other)) else other[:0]) for run, other in pairs]
    used = {int(other[0]) for _, other in pairs if len(other)}
    start, end = (
        Changes(
            np.array([_late(result.fraction, run[at], other[at], periodic) if len(other) else np.nan for run, other in pairs]),
            np.array([run[at] for run, _ in pairs], dtype=np.intp),
            sum(not len(other) for _, other in pairs),
            len(ours) - len(used),
        )
        for at in (0, -1)
    )
    return start, end


def reversals(reference: Cycle, result: Cycle, periodic: bool) -> Changes:
    """First instants of slip in a new sense, to forward and to reverse each in turn; NaN where there are not as many in both."""
    found = [_reversals_to(sense, reference, result, periodic) for sense in (1, -1)]
    return Changes(
        np.concatenate([change.late for change in found]),
        np.concatenate([change.index for change in found]),
        sum(change.missing for change in found),
        sum(change.extra for change in found),
    )


def _reversals_to(sense: int, reference: Cycle, result: Cycle, periodic: bool) -> Changes:
    theirs, ours = (_turns(slip_sense(cycle), sense, periodic) for cycle in (reference, result))
    if len(theirs) != len(ours):
        missing, extra = max(len(theirs) - len(ours), 0), max(len(ours) - len(theirs), 0)
        return Changes(np.full(max(len(theirs), 1), np.nan), theirs if len(theirs) else ours[:1], missing, extra)
    turns = range(len(ours)) if periodic else range(min(len(ours), 1))
    matches = [
        np.array([_late(result.fraction, a, b, periodic) for a, b in zip(theirs, np.roll(ours, k), strict=True)]) for k in turns
    ]
    late = min(matches, key=lambda differences: float(np.max(np.abs(differences))), default=np.zeros(0))
    return Changes(late, theirs)


def slip_sense(cycle: Cycle) -> NDArray[np.int8]:
    """(k,) 1 where more of the length slips forward than in reverse, -1 where less, 0 where neither."""
    forward, reverse = ((cycle.state == s) @ shares(cycle.x) for s in (SLIP_FORWARD, SLIP_REVERSE))
    return np.sign(forward - reverse).astype(np.int8)


def _turns(senses: NDArray[np.int8], sense: int, periodic: bool) -> NDArray[np.intp]:
    """Indices at which slip begins to go in `sense` after it last went in the other, whatever stick there was in between."""
    slipping = np.flatnonzero(senses[:-1] if periodic else senses)
    before = np.roll(senses[slipping], 1)
    turned = (senses[slipping] == sense) & (before == -sense)
    if not periodic:
        turned[:1] = False
    return np.asarray(slipping[turned])


def _late(fraction: Array, expected: int, found: int, periodic: bool) -> float:
    """How much later in the cycle `found` is than `expected`, in a periodic one the shorter way round."""
    late = float(fraction[found] - fraction[expected])
    return (late + 0.5) % 1 - 0.5 if periodic and abs(late) > 0.5 else late
