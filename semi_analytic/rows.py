"""Long measured histories, row by row: a pass of the stack over rows, and what it leaves; memory for the pieces alive only.

# notation: A = 2/E*; P_c load at the front of slip, c = a(P_c); w level +-Q - f P

Rows are taken a chunk at a time: what is kept is what was asked for at the instants asked for, the work of each step where the work
is wanted, and the pieces of the memory curve that are alive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from scenes import InadmissibleLoadError, StraightLeg
from semi_analytic.contact import Contact
from semi_analytic.history import check
from semi_analytic.legs import Instant
from semi_analytic.memory import Curve, Piece
from semi_analytic.row_work import density_of_records, slip_work, work_error
from semi_analytic.stack import Stack, follow_rows

Array = NDArray[np.float64]

_ROUNDING = 1e-14
_CHUNK = 50_000
_UNKNOWN = StraightLeg(0.0, 1.0, (0.0, 0.0), (0.0, 0.0))


@dataclass(frozen=True, eq=False)
class Instants:
    """Instants along a run of rows: `step` (n,) the row that ends each one's step, `share` (n,) how far along it is, ascending."""

    step: NDArray[np.int64]
    share: Array

    def __len__(self) -> int:
        return len(self.step)


@dataclass(frozen=True, eq=False)
class Wanted:
    """What a pass over the rows has to leave: work, work at |x| = `x` (k,) if there are any, curves at instants or not."""

    work: bool
    curves: bool
    x: Array


@dataclass(eq=False)
class Pass:
    """What one pass over rows left behind.

    Attributes
    ----------
    forward, reverse : friction work over f A/pi [force^2 per thickness^2]
    doubt : error of both together from above, 0 for closed forms
    density : (k,) the same at points, forward and reverse together [stress * force per thickness]
    each : (rows,) work in the step that ends at each row, where work was wanted
    front, held, direction : (n,) P_c, M(P_c) and direction of slip at the instants
    curves : the pieces below the front at the instants, where they were wanted
    least, deepest : the lowest front P_c, the largest P - P_c
    rows, slips, alive, dropped : counts
    """

    forward: float = 0.0
    reverse: float = 0.0
    doubt: float = 0.0
    density: Array = field(default_factory=lambda: np.zeros(0))
    each: list[Array] = field(default_factory=list)
    front: list[Array] = field(default_factory=list)
    held: list[Array] = field(default_factory=list)
    direction: list[NDArray[np.int8]] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    least: float = math.inf
    deepest: float = 0.0
    rows: int = 0
    slips: int = 0
    alive: int = 0
    dropped: int = 0

    @property
    def work(self) -> float:
        """Forward and reverse together."""
        return self.forward + self.reverse


class Shelf:
    """Pieces of the curves of successive instants, those that stayed alive in between being shared."""

    def __init__(self) -> None:
        self._pieces: list[Piece] = []

    def curve(self, loads: list[float], forces: list[float]) -> Curve:
        """The curve through the knots, the first of them (0, 0)."""
        made, top = self._pieces, self._pieces[-1] if self._pieces else None
        common = 0
        for piece, load, force in zip(made, loads[1:], forces[1:], strict=False):
            if piece.top != load or piece.anchor.tangential != force:
                break
            common += 1
        del made[common:]
        for k in range(common + 1, len(loads)):
            top = made[-1] if made else None
            slope = (forces[k] - forces[k - 1]) / (loads[k] - loads[k - 1])
            made.append(Piece(top, loads[k], Instant(_UNKNOWN, math.nan, loads[k], forces[k]), slope))
        return made[-1] if made else None


def check_rows(rows: Array, friction: float) -> None:
    """Raise InadmissibleLoadError at the first gross sliding or separation; lines between admissible points are admissible."""
    normal, tangential = rows[:, 1], rows[:, 2]
    slack = _ROUNDING * float(np.max(np.abs(normal)))
    bad = np.flatnonzero((normal < -slack) | (np.abs(tangential) > friction * (normal + slack)))
    if len(bad):
        before, after = rows[max(int(bad[0]) - 1, 0)].tolist(), rows[bad[0]].tolist()
        leg = StraightLeg(before[0], after[0], (before[1], before[2]), (after[1], after[2]))
        check([leg], friction)
        raise InadmissibleLoadError("separation" if after[1] < -slack else "gross sliding", after[0], after[1], after[2], friction)


def run(stack: Stack, rows: Array, instants: Instants, wanted: Wanted, contact: Contact) -> Pass:
    """Straight steps from where the stack stands through `rows` (m, 2) of P and Q."""
    left = Pass(density=np.zeros(len(wanted.x)))
    shelf = Shelf()
    off = (instants.share < 1) | wanted.curves
    stops = np.unique(instants.step[off])
    marks = np.unique(np.concatenate([np.arange(0, len(rows), _CHUNK), stops, stops + 1, [0, len(rows)]]))
    marks = marks[marks <= len(rows)]
    at = np.searchsorted(instants.step, marks)
    for k, (begin, end) in enumerate(zip(marks[:-1].tolist(), marks[1:].tolist(), strict=True)):
        here = slice(int(at[k]), int(at[k + 1]))
        _advance(left, stack, rows[begin:end], instants.step[here] - begin, instants.share[here], wanted, contact, shelf)
    return left


def _advance(
    left: Pass,
    stack: Stack,
    rows: Array,
    step: NDArray[np.int64],
    share: Array,
    wanted: Wanted,
    contact: Contact,
    shelf: Shelf,
) -> None:
    """A chunk of rows: either instants at rows without curves, or one row with instants on the way to it."""
    if len(step) and (wanted.curves or np.any(share < 1)):
        _look(left, stack, rows[0], share, wanted, shelf)
        step = step[:0]
    followed = follow_rows(stack, rows[:, 0], rows[:, 1])
    left.rows, left.slips = left.rows + len(rows), left.slips + len(followed.records.row)
    left.alive, left.dropped = max(left.alive, followed.alive), left.dropped + followed.dropped
    left.least = min(left.least, float(np.min(followed.front)))
    if len(step):
        left.front.append(followed.front[step])
        left.held.append(followed.held[step])
        left.direction.append(followed.direction[step])
    if wanted.work:
        work = slip_work(contact, followed.records)
        slipped = followed.records.load_after - followed.records.front_after
        left.deepest = max(left.deepest, float(np.max(slipped, initial=0.0)))
        ahead = followed.records.direction > 0
        left.forward, left.reverse = left.forward + float(np.sum(work[ahead])), left.reverse + float(np.sum(work[~ahead]))
        left.doubt += work_error(contact, followed.records)
        left.each.append(np.bincount(followed.records.row, work, len(rows)).astype(float))
    if len(wanted.x):
        left.density += density_of_records(contact, followed.records, wanted.x)


def _look(left: Pass, stack: Stack, row: Array, share: Array, wanted: Wanted, shelf: Shelf) -> None:
    """The state at parts of the step to `row`, by steps of a copy of the stack."""
    begin = np.array([stack.loads[-1], stack.forces[-1]])
    for part in share.tolist():
        trial = stack.copy()
        p, q = (row if part == 1 else begin + part * (row - begin)).tolist()
        direction = trial.step(p, q)
        front, held = (trial.front, trial.held) if direction else (p, q)
        left.front.append(np.array([front]))
        left.held.append(np.array([held]))
        left.direction.append(np.array([direction], dtype=np.int8))
        if wanted.curves:
            knots = len(trial.loads) - (1 if direction and front < p and len(trial.loads) > 1 else 0)
            left.curves.append(shelf.curve(trial.loads[:knots], trial.forces[:knots]))
