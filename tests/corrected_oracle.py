"""Two half-planes to whose gap and faces curvature is added, by brute force: cells of constant
traction, an active set, small steps. No flat punches, no memory curve.

    gap(x)  = h(x) + kn x^2/2 - (A/pi) int p ln|x - xi| d xi - delta
    slip(x) = U - kt x^2/2 + (A/pi) int q ln|x - xi| d xi

with gap >= 0 and p >= 0 of which one is 0, |q| <= f p, slip only where |q| = f p and along q. All
is mirrored at x = 0; kn and kt follow the loads. A = 2/E*.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes.array_types import Array

_MOST_SETS = 500


class StepOfShear(NamedTuple):
    """q and slip of the cells after a step, (m,) each."""

    shear: Array
    slip: Array


class StepsOfContact(NamedTuple):
    """Work of each step (n,), p, q and slip of the cells after it (n, m)."""

    work: Array
    pressure: Array
    shear: Array
    slip: Array


class CellContact:
    """A contact within |x| < `reach`, in cells of one length."""

    def __init__(self, compliance: float, reach: float, cells: int) -> None:
        self.length = reach / cells
        self.x = (np.arange(cells) + 0.5) * self.length
        right = self._primitive_rise(self.x[:, None] - self.x)
        left = self._primitive_rise(self.x[:, None] + self.x)
        self._influence = -compliance / np.pi * (right + left)

    def _primitive_rise(self, distance: Array) -> Array:
        """Int of ln|u| du over a cell at these distances."""

        def primitive(u: Array) -> Array:
            return u * np.log(np.abs(u)) - u

        half = self.length / 2
        return primitive(distance + half) - primitive(distance - half)

    def _balanced(self, cells: NDArray[np.int64], bend: Array, force: float) -> Array:
        """Tractions of these cells that displace them by a constant minus `bend`, of resultant
        `force`; and the constant, last.
        """
        count = len(cells)
        system = np.zeros((count + 1, count + 1))
        system[:-1, :-1] = self._influence[np.ix_(cells, cells)]
        system[:-1, -1] = -1.0
        system[-1, :-1] = 2 * self.length
        return np.linalg.solve(system, np.append(-bend, force))

    def pressure(self, gap: Array, load: float) -> Array:
        """p of a gap that opens from x = 0 on, under a load."""
        count = len(self.x) // 2
        for _ in range(_MOST_SETS):
            cells = np.arange(count)
            solved = self._balanced(cells, gap[:count], load)
            if solved[count - 1] < 0:
                count -= 1
                continue
            next_gap = gap[count] + self._influence[count, :count] @ solved[:-1] - solved[-1]
            if next_gap >= 0:
                return np.append(solved[:-1], np.zeros(len(self.x) - count))
            count += 1
        raise AssertionError("no contact was found")

    def step(self, limit: Array, slip_before: Array, bend: Array, force: float) -> StepOfShear:
        """q under the limit f p, and the slip after a step from `slip_before`."""
        touching = np.flatnonzero(limit > 0)
        limit_there = limit[touching]
        target = (slip_before + bend)[touching]
        influence = self._influence[np.ix_(touching, touching)]
        sense = np.zeros(len(touching))
        for _ in range(_MOST_SETS):
            shear = sense * limit_there
            sticks = np.flatnonzero(sense == 0)
            rest = force - 2 * self.length * float(np.sum(shear))
            solved = self._balanced(
                touching[sticks], target[sticks] + influence[sticks] @ shear, rest
            )
            shear[sticks] = solved[:-1]
            moved = solved[-1] - influence @ shear - target
            new_sense = sense.copy()
            beyond = np.abs(shear[sticks]) > limit_there[sticks] * (1 + 1e-12)
            new_sense[sticks] = np.where(beyond, np.sign(shear[sticks]), 0.0)
            turned = (sense != 0) & (moved * sense < -1e-15)
            new_sense[turned] = 0.0
            if np.array_equal(new_sense, sense):
                break
            sense = new_sense
        else:
            raise AssertionError("no slip zone was found")
        whole_shear = np.zeros(len(self.x))
        whole_shear[touching] = shear
        slip = solved[-1] - self._influence @ whole_shear - bend
        return StepOfShear(whole_shear, slip)

    def follow(
        self,
        height: Array,
        friction: float,
        loads: Array,
        curvatures: Array,
        fourths: Array | None = None,
    ) -> StepsOfContact:
        """Along rows of P, Q (n, 2), of kn, kt (n, 2), and of what x^4/24 is added with to gap and
        faces, (n, 2).
        """
        if fourths is None:
            fourths = np.zeros((len(loads), 2))
        slip = np.zeros(len(self.x))
        work = np.zeros(len(loads))
        pressure = np.zeros((len(loads), len(self.x)))
        shear = np.zeros((len(loads), len(self.x)))
        slips = np.zeros((len(loads), len(self.x)))
        half_square = self.x**2 / 2
        quartic = self.x**4 / 24
        for row, (load, force) in enumerate(loads):
            if load <= 0:
                continue
            gap_bend, face_bend = curvatures[row].tolist()
            gap_fourth, face_fourth = fourths[row].tolist()
            of_gap = gap_bend * half_square + gap_fourth * quartic
            of_faces = face_bend * half_square + face_fourth * quartic
            pressure[row] = self.pressure(height + of_gap, load)
            after = self.step(friction * pressure[row], slip, of_faces, force)
            rubbed = np.where(pressure[row] > 0, np.abs(after.shear * (after.slip - slip)), 0.0)
            work[row] = 2 * self.length * float(np.sum(rubbed))
            slip = after.slip
            shear[row] = after.shear
            slips[row] = slip
        return StepsOfContact(work, pressure, shear, slips)
