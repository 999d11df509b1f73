"""The memory curve of straight steps as a stack of knots: a constant cost a step on average, memory for the knots alive only.

# notation: (E, M) knots of the curve M(eta), the first (0, 0), the last (P, Q); s direction of slip; level s M - f eta, which falls
#           with eta; P_c load at the front of slip

Every knot is put on the stack once and taken off once. A step of slip leaves one record for each piece of the curve that its
front goes through: along it P, P_c and the level are linear in one another.
"""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROUNDING = 1e-15
_LAST_DIGITS = 4e-15


class Records(NamedTuple):
    """Pieces of slip, (m,) each: direction, P and P_c at both ends, rise of the level; `row` is the step they belong to."""

    direction: Array
    load: Array
    load_after: Array
    front: Array
    front_after: Array
    rise: Array
    row: NDArray[np.int64]


@dataclass
class Stack:
    """The curve while it is being followed: the one thing here that changes in place, kept inside `follow_rows`."""

    friction: float
    loads: list[float] = field(default_factory=lambda: [0.0])
    forces: list[float] = field(default_factory=lambda: [0.0])
    records: array[float] = field(default_factory=lambda: array("d"))
    dropped: int = 0
    front: float = 0.0
    held: float = 0.0

    def copy(self) -> Stack:
        """The same curve, to try a step on."""
        return Stack(self.friction, self.loads.copy(), self.forces.copy())

    def step(self, normal: float, tangential: float) -> int:
        """Go straight to (P, Q): the direction of slip at the end of the step, 0 if none."""
        p, q = self.loads[-1], self.forces[-1]
        change, limit = normal - p, self.friction * (normal - p)
        force = tangential - q
        if change >= 0 and -limit <= force <= limit:
            if change > 0:
                self._grow(normal, tangential)
            return 0
        if change < 0 and limit <= force <= -limit:
            return self._unload(normal, tangential)
        direction = 1 if force > 0 else -1
        self._slip(direction, normal, tangential)
        return direction

    def _grow(self, normal: float, tangential: float) -> None:
        loads, forces = self.loads, self.forces
        if len(loads) > 1:
            # The same line goes on: one piece.
            before = (forces[-1] - forces[-2]) * (normal - loads[-1])
            after = (tangential - forces[-1]) * (loads[-1] - loads[-2])
            if abs(before - after) <= _ROUNDING * (abs(before) + abs(after)):
                loads.pop()
                forces.pop()
                self.dropped += 1
        loads.append(normal)
        forces.append(tangential)

    def _slip(self, s: int, normal: float, tangential: float) -> None:
        """Slip in direction s along a straight step from the top of the stack: the front goes down through the pieces."""
        loads, forces, f = self.loads, self.forces, self.friction
        e1, m1 = loads.pop(), forces.pop()
        level = begin = s * m1 - f * e1
        # |Q| <= f P was checked: what is above 0 is rounding.
        end = min(s * tangential - f * normal, 0.0)
        # A front that meets a knot at the very end of the step, to rounding, has not passed it: what lies below may be at the limit
        # already, and the front would jump through it.
        reached = end - _LAST_DIGITS * f * max(e1, normal)
        p = start = e1
        rate = (normal - start) / (end - begin) if end > begin else 0.0
        while loads:
            e0, m0 = loads[-1], forces[-1]
            lower = s * m0 - f * e0
            if lower >= reached or len(loads) == 1:
                break
            if lower > level:
                after = start + (lower - begin) * rate
                self.records.extend((s, p, after, e1, e0, lower - level))
                p, level = after, lower
            e1, m1 = e0, m0
            loads.pop()
            forces.pop()
            self.dropped += 1
        if end > level and lower > level:
            share = min((end - level) / (lower - level), 1.0)
            front, held = e1 + share * (e0 - e1), m1 + share * (m0 - m1)
            self.records.extend((s, p, normal, e1, front, end - level))
        else:
            front, held = e1, m1
        self.front, self.held = min(front, normal), held
        if loads[-1] < front < normal:
            loads.append(front)
            forces.append(held)
        if normal > loads[-1]:
            loads.append(normal)
            forces.append(tangential)

    def _unload(self, normal: float, tangential: float) -> int:
        """P falls and |dQ| <= f |dP|: slip to the side of the curve on which the path runs, in parts where it crosses the curve."""
        direction = 0
        for p, q, s in self._sides(normal, tangential):
            if s:
                self._slip(s, p, q)
            else:
                self._cut(p, q)
            direction = s
        return direction

    def _sides(self, normal: float, tangential: float) -> list[tuple[float, float, int]]:
        """(P, Q, direction) at the end of each part."""
        loads, forces = self.loads, self.forces
        p, q = loads[-1], forces[-1]
        slope = (tangential - q) / (normal - p)
        noise = _ROUNDING * 8 * self.friction * p
        parts: list[tuple[float, float, int]] = []
        sign, above, upper = 0, 0.0, p
        for k in range(len(loads) - 2, -1, -1):
            e, m = loads[k], forces[k]
            if e < normal:
                m += (forces[k + 1] - m) * (normal - e) / (loads[k + 1] - e)
                e = normal
            now = q + slope * (e - p) - m
            side = 0 if abs(now) <= noise else (1 if now > 0 else -1)
            if side and sign and side != sign:
                crossing = upper + (e - upper) * above / (above - now)
                parts.append((crossing, q + slope * (crossing - p), sign))
            sign, above, upper = side or sign, now, e
            if e <= normal:
                break
        parts.append((normal, tangential, sign))
        return parts

    def _cut(self, normal: float, tangential: float) -> None:
        loads, forces = self.loads, self.forces
        while len(loads) > 1 and loads[-1] >= normal:
            loads.pop()
            forces.pop()
            self.dropped += 1
        if normal > loads[-1]:
            loads.append(normal)
            forces.append(tangential)


class Followed(NamedTuple):
    """What a series of rows leaves: records, per row the direction, P_c and M(P_c), the most knots ever alive, knots taken off."""

    records: Records
    direction: NDArray[np.int8]
    front: Array
    held: Array
    alive: int
    dropped: int


def follow_rows(stack: Stack, normal: Array, tangential: Array) -> Followed:
    """Straight steps to each row (n,) in turn; `stack` goes with them.

    >>> followed = follow_rows(Stack(0.5), np.array([2.0, 2.0, 2.0]), np.array([0.0, 0.5, -0.5]))
    >>> followed.front.tolist(), followed.alive  # P - Q/f, then P - (Q - Q')/(2 f)
    ([2.0, 1.0, 1.0], 3)
    """
    count = len(normal)
    direction, front, held = array("b", bytes(count)), array("d", bytes(8 * count)), array("d", bytes(8 * count))
    ends = array("q", bytes(8 * count))
    stack.records = array("d")
    alive, before = 1, stack.dropped
    step, loads, records = stack.step, stack.loads, stack.records
    for k, (p, q) in enumerate(zip(normal.tolist(), tangential.tolist(), strict=True)):
        s = step(p, q)
        direction[k] = s
        if s:
            front[k], held[k] = stack.front, stack.held
        else:
            front[k], held[k] = p, q
        ends[k] = len(records)
        alive = max(alive, len(loads))
    table = np.frombuffer(records, dtype=float).reshape(-1, 6) if len(records) else np.empty((0, 6))
    counts = np.diff(np.concatenate([[0], np.frombuffer(ends, dtype=np.int64)])) // 6
    sense, load, load_after, at, at_after, rise = (table[:, k].copy() for k in range(6))
    found = Records(sense, load, load_after, at, at_after, rise, np.repeat(np.arange(count), counts))
    rows = (np.frombuffer(direction, dtype=np.int8), np.frombuffer(front), np.frombuffer(held))
    return Followed(found, *rows, alive, stack.dropped - before)
