"""Contact, stick and slip of a foreign result, worked out from its tractions and, where it has one, its slip.

# notation: f friction coefficient, h spacing of the points
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reports.scoring.guesses import TOUCHES
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A point slips where |q| is f p less this share, and, where there is a slip, that has moved by more than the second share of the
# largest movement of the instant. A stick zone ends like the root of the distance: one per cent of f p is a ten-thousandth of a.
CONE = 0.01
MOVES = 1e-3
# An instant at which no point of the contact moves faster than this share of the largest rate of all is at rest: where slip turns,
# it is the digits of the slip that tell who moves.
RESTS = 0.02


@dataclass(frozen=True, eq=False)
class Zones:
    """state (n_steps, n_points) as int8; contact_edges and stick_edges (n_steps, 2) [length]; how they were told, in words."""

    state: NDArray[np.int8]
    contact_edges: Array
    stick_edges: Array
    notes: tuple[str, ...]


class Tractions(Protocol):
    """What states and edges are told from: of a foreign result, or of a reference by the same rule."""

    @property
    def x(self) -> Array: ...
    @property
    def pressure(self) -> Array: ...
    @property
    def shear(self) -> Array: ...
    @property
    def slip(self) -> Array | None: ...


def zones(result: Tractions, friction: float, time: Array) -> Zones:
    """States and edges. In full stick the stick edges are the contact edges, in full slip NaN, as everywhere in the project.

    A contact edge lies where the straight line of p^2 through the last two points in contact is 0, a stick edge where that of
    (f p - |q|)^2 is, each no farther than the next point: both are roots of the distance at an edge.
    """
    touching = result.pressure > TOUCHES * result.pressure.max(axis=1, keepdims=True)
    slips, sense = _slips(result, friction, touching, time)
    state = np.where(touching, np.where(slips, np.where(sense > 0, SLIP_FORWARD, SLIP_REVERSE), STICK), OPEN).astype(np.int8)
    contact = np.array([_edges(result.x, row**2, here) for row, here in zip(result.pressure, touching, strict=True)])
    short = friction * result.pressure - np.abs(result.shear)
    sticks = touching & ~slips
    stick = np.array([_edges(result.x, np.maximum(row, 0.0) ** 2, here) for row, here in zip(short, sticks, strict=True)])
    # Where the outermost points of the contact stick, the stick zone ends with it.
    for side, at in ((0, 0), (1, -1)):
        for k in range(len(stick)):
            inside = np.flatnonzero(touching[k])
            if len(inside) and sticks[k, inside[at]]:
                stick[k, side] = contact[k, side]
    return Zones(state, contact, stick, _notes(result, friction))


def _slips(result: Tractions, friction: float, touching: Mask, time: Array) -> tuple[Mask, Array]:
    """Which points slip, and in which sense; the first instant has no step before it, so that there the cone alone tells."""
    on_cone = touching & (np.abs(result.shear) >= (1 - CONE) * friction * result.pressure)
    sense = np.sign(result.shear)
    if result.slip is None or len(result.slip) < 2:
        return on_cone, sense
    moved = np.where(touching[1:], np.diff(result.slip, axis=0), 0.0)
    largest = np.max(np.abs(moved), axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(largest > 0, largest / np.diff(time)[:, None], 0.0)
    far = (np.abs(moved) > MOVES * largest) & (rate >= RESTS * np.max(rate))
    if not friction:
        return np.vstack([on_cone[:1], far]), np.vstack([sense[:1], np.sign(moved)])
    return np.vstack([on_cone[:1], on_cone[1:] & far & (np.sign(moved) == sense[1:])]), sense


def _edges(x: Array, square: Array, inside: Mask) -> tuple[float, float]:
    """Left and right end of `inside`, where `square` (n,) goes to 0; NaN where nothing is inside."""
    points = np.flatnonzero(inside)
    if not len(points):
        return np.nan, np.nan
    left, right = int(points[0]), int(points[-1])
    return _end(x, square, left, -1), _end(x, square, right, 1)


def _end(x: Array, square: Array, last: int, outward: int) -> float:
    """Where the line of `square` through the points `last` and the one before is 0, between `last` and the next point."""
    following, before = last + outward, last - outward
    if not 0 <= following < len(x):
        return float(x[last])
    reach = abs(float(x[following] - x[last]))
    if not 0 <= before < len(x) or square[before] <= square[last]:
        return float(x[last]) + outward * reach / 2
    slope = (square[before] - square[last]) / abs(float(x[last] - x[before]))
    return float(x[last]) + outward * min(float(square[last] / slope), reach)


def _notes(result: Tractions, friction: float) -> tuple[str, ...]:
    touches = f"in contact is a point with more than {TOUCHES:g} of the instant's largest pressure"
    if not friction:
        return (f"states and edges are worked out from its tractions: {touches}",)
    cone = f"it slips where |q| is at least {1 - CONE:g} f p"
    if result.slip is None or len(result.slip) < 2:
        blind = "for want of slip, a point that just came to rest still counts as slipping"
        return (f"states and edges are worked out from its tractions: {touches}; {cone}; {blind}",)
    moves = (
        f"and its slip has moved with the shear by more than {MOVES:g} of the instant's largest step, unless no point moves faster "
        f"than {RESTS:g} of the largest rate"
    )
    return (f"states and edges are worked out from its tractions and slip: {touches}; {cone} {moves}",)
