"""Events: when the next node touches or lets go, and arriving there.

With the states of the nodes held, forces are linear in the loads, and the normal problem of like bodies depends on P alone, or on P
and the tilt: one linear prediction finds the event. Between unlike bodies it depends on Q too, and on what sticks: there the
prediction misses by the square of the increment, and the next one starts from where it missed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, freeze

Array = NDArray[np.float64]
Event = Literal["regular", "touch", "release"]
LoadsAt = Callable[[float], tuple[float, ...]]

# Gap and nodal force within which a node counts as met by an event, scaled.
_LANDED = 1e-9


def next_event(problem: ContactProblem, history: InterfaceState, loads_at: LoadsAt, end: float) -> tuple[Event, float]:
    """What happens first up to `end` to the set of touching nodes, and when, by one linear prediction."""
    held = problem.holding(history, end, loads_at(end))
    fractions: dict[Event, tuple[float, int]] = {
        "touch": _first_crossing(history.gap, held.gap, ~history.closed),
        "release": _first_crossing(history.pressure, held.pressure, history.closed),
    }
    event = min(fractions, key=lambda name: fractions[name][0])
    share, node = fractions[event]
    if share >= 1.0:
        return "regular", end
    if len(history.loads) == 2:
        start_load, end_load = loads_at(history.time)[0], loads_at(end)[0]
        wanted = start_load + share * (end_load - start_load)

        def left(time: float) -> float:
            return loads_at(time)[0] - wanted

        if not min(start_load, end_load) < wanted < max(start_load, end_load):
            return "regular", end
    else:  # by tilt nodes meet at constant P too: the gap or the force of the first of them, as the loads go
        name, moving = ("gap" if event == "touch" else "pressure"), np.flatnonzero(np.subtract(held.loads, history.loads)).tolist()
        before, rates = float(getattr(history, name)[node]), problem.rates(history.state, len(history.loads), moving)
        by_load = [float(getattr(rates[number], name)[node]) for number in moving]

        def left(time: float) -> float:
            return before + float(np.subtract(loads_at(time), history.loads)[moving] @ by_load)

    time = float(brentq(left, history.time, end, xtol=1e-15, rtol=8.9e-16))
    if not history.time < time < end:
        return "regular", end
    return event, time


def _first_crossing(before: Array, after: Array, nodes: NDArray[np.bool_]) -> tuple[float, int]:
    """Fraction of the increment at which the first of `nodes` goes from positive to negative, linearly, and it; 1 if none does."""
    falling = np.flatnonzero(nodes & (before > ROUNDING) & (after < -ROUNDING))
    if not len(falling):
        return 1.0, -1
    shares = before[falling] / (before[falling] - after[falling])
    first = int(np.argmin(shares))
    return float(shares[first]), int(falling[first])


def up_to_event(history: InterfaceState, solved: InterfaceState) -> InterfaceState:
    """`solved` with nodes that are at their event on the side where they have been: there, within rounding, the law takes either.

    A node that let go in its increment has slid for all of it, and one labelled open would lose the friction work.
    """
    slip = solved.slip - history.slip
    sliding = np.where(slip > ROUNDING, SLIP_FORWARD, SLIP_REVERSE)
    closed_until_now = np.where(np.abs(slip) > ROUNDING, sliding, STICK)
    changed = _marginal(solved) & (solved.closed != history.closed)
    states = np.where(changed, np.where(history.closed, closed_until_now, OPEN), solved.state)
    return replace(solved, state=freeze(states, np.int8))


def _marginal(state: InterfaceState) -> NDArray[np.bool_]:
    return (np.abs(state.gap) <= _LANDED) & (np.abs(state.pressure) <= _LANDED)


def landed(state: InterfaceState, event: Event) -> InterfaceState:
    """`state` with the nodes of the event on their new side: a touching node sticks from here on, a released one is open."""
    if event == "regular":
        return state
    new = STICK if event == "touch" else OPEN
    return replace(state, state=freeze(np.where(_marginal(state), new, state.state), np.int8))
