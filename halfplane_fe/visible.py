"""What a node does as a reader sees it: the law's states less creep at the turning points of the load."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import InterfaceState
from halfplane_fe.law import slip_sign
from scenes import OPEN, STICK

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
    law = np.array([state.state for state in states])
    increments = np.diff(np.array([states[0].slip, *(state.slip for state in states)]), axis=0)
    increments[np.abs(increments) <= _ROUNDING * np.abs(increments).max(initial=0.0)] = 0.0
    run = np.zeros_like(increments)  # slip in one direction without a stop, open or closed
    for step in range(1, len(states)):
        goes_on = run[step - 1] * increments[step] > 0
        run[step] = np.where(goes_on, run[step - 1], 0.0) + increments[step]
    forward = slip_sign(law) * run
    moved = forward > _MOVED * forward.max(axis=1, keepdims=True)
    loads = np.array([(state.normal_load, state.tangential_load) for state in states])
    change = np.abs(np.diff(loads, axis=0, prepend=loads[:1])).sum(axis=1)
    along = slip_sign(law) * np.diff(loads[:, 1], prepend=0.0)[:, None]  # forward slip is driven while Q - f P grows, reverse
    driven = along > friction * np.diff(loads[:, 0], prepend=0.0)[:, None]  # slip while Q + f P falls
    pace = np.abs(increments) * (slip_sign(law) != 0) / np.maximum(change, 1e-300)[:, None]
    for part in np.split(np.arange(len(states)), np.asarray(cycle_starts, dtype=int) + 1):
        fastest = pace[part].max(initial=0.0)
        moved[part] |= pace[part] > _BRISK * fastest
        for step in part:
            goes_on = driven[step] & (moved[step - 1] & (run[step] * run[step - 1] > 0) if step else False)
            moved[step] &= pace[step] > np.where(goes_on, _DYING, _CREEP) * fastest
            moved[step, _slow_rim(law[step], moved[step], pace[step] > _RIM_CREEP * fastest)] = False
    return np.where((slip_sign(law) != 0) & ~moved, STICK, law).astype(np.int8)


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
