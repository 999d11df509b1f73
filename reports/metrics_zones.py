"""How far two cycles' contact, stick and slip are apart: see `metrics` for what all have in common."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reports.metrics import Array, over, shares
from reports.sampling import Cycle
from scenes import OPEN, STICK


def edge(expected: Array, found: Array, length: float) -> Array:
    """Outward shift of the worse of two edges over `length`, (k,) from (k, 2); positive where it reaches too far.

    NaN where either lacks the edge (a stick edge in full slip).

    >>> edge(np.array([[-1.0, 1.0]]), np.array([[-1.02, 1.01]]), 1.0).round(12).tolist()
    [0.02]
    """
    outward = (found - expected) * np.array([-1.0, 1.0]) / length
    worse = np.argmax(np.abs(outward), axis=1)
    return np.asarray(outward[np.arange(len(outward)), worse])


def stick_status(cycle: Cycle, length: float) -> NDArray[np.int8]:
    """What the whole contact does at each instant, (k,): 0 full slip, 1 partial slip, 2 full stick, -1 out of contact.

    Full stick is told by stick edges that are the contact edges (to 1e-9 `length`), full slip by NaN.
    """
    apart = np.max(np.abs(cycle.stick_edges - cycle.contact_edges), axis=1)
    status = np.where(np.isnan(apart), 0, np.where(apart <= 1e-9 * length, 2, 1))
    return np.where(cycle.pressure.max(axis=1) > 0, status, -1).astype(np.int8)


def state_disagreement(reference: Cycle, result: Cycle) -> Array:
    """Share of the length in contact (of either) whose state differs, at each instant, (k,); NaN out of contact."""
    touching = (reference.state != OPEN) | (result.state != OPEN)
    differs = reference.state != result.state
    length = np.gradient(result.x)
    return over((differs * length).sum(axis=1), (touching * length).sum(axis=1))


def edge_of_side(expected: Array, found: Array, side: int, length: float) -> Array:
    """Outward shift of the left (0) or right (1) edge over `length`, (k,) from (k, 2); NaN where either lacks it."""
    return (found[:, side] - expected[:, side]) * (-1.0, 1.0)[side] / length


def stick_set(reference: Cycle, result: Cycle) -> float:
    """1 - |A and B|/|A or B| of the points and instants that stick, by length times time, in [0, 1]; NaN if none does in either."""
    theirs, ours = reference.state == STICK, result.state == STICK
    both, either = (shares(result.time) @ sticks @ shares(result.x) for sticks in (theirs & ours, theirs | ours))
    return float(1 - over(both, either))


def slip(reference: Cycle, result: Cycle, slip_scale: float) -> tuple[Array, Array, bool]:
    """s - s_ref over the range of s_ref in contact, (k, n); what each point that is in contact in both stands for, (k, n) [length].

    And whether it is relative: it is over `slip_scale` = f p_ref a_ref/E* where the range of s_ref is below 1e-12 of that.
    """
    touching = (reference.state != OPEN) & (result.state != OPEN)
    largest = np.ptp(reference.slip[touching]) if touching.any() else 0.0
    relative = not bool(largest <= 1e-12 * slip_scale)
    difference = (result.slip - reference.slip) / (largest if relative else slip_scale)
    return difference, touching * shares(result.x), relative


def slip_norm(difference: Array, lengths: Array) -> Array:
    """Root of the mean square of `difference` (k, n) over `lengths` (k, n) at each instant, (k,) >= 0; NaN without any."""
    return np.sqrt(over((np.where(lengths > 0, difference, 0.0) ** 2 * lengths).sum(axis=1), lengths.sum(axis=1)))
