"""What a node does as a reader sees it: the law's states less creep at the turning points of the load."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import InterfaceState
from halfplane_fe.law import slip_sign
from scenes import OPEN, STICK

Array = NDArray[np.float64]
States = NDArray[np.int8]

# A sliding node that has come less far, since it last stuck or turned round, than this share of the farthest one counts as
# sticking: at the turning points of the load whole regions come back to the cone at once, and creep there by the mesh's error.
# Slip grows as the distance from the stick edge to the power 3/2, so the share costs a hundredth of the slip zone at most.
_MOVED = 1e-3
# ... unless it is on its way: slip per change of load, over the largest of the revolution, that no creep has.
_BRISK = 2e-2
# The same of a node whose slip per change of load is less than this share of the largest of the revolution, at turning points; of
# one that has been sliding and that the load still drives, so that its slip dies away towards a turning point, the second share.
_CREEP, _DYING = 5e-4, 5e-5
# The same of the outermost nodes of the contact, where they alone slide: a slip zone of width w slides at its rim about
# sqrt(2 w/a) times as fast as the largest ever does, a tenth to a fifth for these; a twentieth of that is the mesh's error. Where
# they have sticking nodes among them, a single one that has just come to touch may be faster.
_RIM, _RIM_CREEP = 5, 5e-3
# Slip of an increment, over the largest of all, below which it is rounding.
_ROUNDING = 1e-9


def visible_states(states: Sequence[InterfaceState], cycle_starts: Sequence[int], friction: float) -> States:
    """(n_steps, n) states as the user sees them: a node on the cone that has hardly moved since it last stuck sticks.

    Parameters
    ----------
    states : of the whole path
    cycle_starts : index of the state at which each revolution starts; what comes before them is the initial loading
    friction : coefficient f
    """
    # Row by row: arrays of all steps and nodes would take gigabytes of a long record.
    seen = np.array([state.state for state in states])
    loads = np.array([state.loads for state in states])
    change = np.abs(np.diff(loads, axis=0, prepend=loads[:1])).sum(axis=1)
    normal, tangential = np.diff(loads[:, 0], prepend=0.0), np.diff(loads[:, 1], prepend=0.0)

    def increment(step: int) -> Array:
        return np.asarray(states[step].slip - states[max(step - 1, 0)].slip)

    rounding = _ROUNDING * max(float(np.abs(increment(step)).max(initial=0.0)) for step in range(len(states)))

    def moves(step: int) -> tuple[NDArray[np.int64], Array, Array]:
        """Direction by the law, slip of the increment, and that of a sliding node per change of load: (n,) each."""
        sign, slip = slip_sign(states[step].state), increment(step)
        slip[np.abs(slip) <= rounding] = 0.0
        return sign, slip, np.abs(slip) * (sign != 0) / max(change[step], 1e-300)

    run, moved = np.zeros_like(states[0].slip), np.zeros(len(states[0].slip), dtype=bool)
    for part in np.split(np.arange(len(states)), np.asarray(cycle_starts, dtype=int) + 1):
        fastest = max((float(moves(step)[2].max(initial=0.0)) for step in part.tolist()), default=0.0)
        for step in part.tolist():
            sign, slip, pace = moves(step)
            before, along = run, sign * tangential[step]
            run = np.where(before * slip > 0, before, 0.0) + slip  # slip in one direction without a stop, open or closed
            forward = sign * run
            driven = along > friction * normal[step]  # forward slip is driven while Q - f P grows, reverse slip while Q + f P falls
            goes_on = driven & (moved & (run * before > 0) if step else False)
            moved = (forward > _MOVED * forward.max()) | (pace > _BRISK * fastest)
            moved &= pace > np.where(goes_on, _DYING, _CREEP) * fastest
            moved[_slow_rim(states[step].state, moved, pace > _RIM_CREEP * fastest)] = False
            seen[step] = np.where((sign != 0) & ~moved, STICK, states[step].state)
    return seen.astype(np.int8)


def _slow_rim(law: States, moved: NDArray[np.bool_], fast: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Sliding nodes of each half of the contact, where all are among its outermost and none is fast, or few with gaps between."""
    closed = np.flatnonzero(law != OPEN)
    half = len(closed) // 2
    slow = []
    for side in (closed[:half], closed[half:][::-1]):  # from the rim inwards
        sliding = side[(slip_sign(law[side]) != 0) & moved[side]]
        if not len(sliding) or not np.isin(sliding, side[:_RIM]).all():
            continue
        gaps = np.ptp(sliding) >= len(sliding)
        if not fast[sliding].any() or (gaps and np.mean(fast[sliding]) < 0.5):
            slow.append(sliding)
    return np.concatenate(slow) if slow else np.zeros(0, dtype=np.int64)
