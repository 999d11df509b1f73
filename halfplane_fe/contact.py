"""Contact and friction of two condensed bodies at one load: the active set that meets the law at every node.

All in scaled variables: lengths over the half-width, forces over the largest load P, displacements over P/E*.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lu_factor, lu_solve

from halfplane_fe.interface import Interface
from halfplane_fe.law import project, slip_sign
from scenes import ConvergenceError, SurfaceState, freeze

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
States = NDArray[np.int8]

# Rounding of nodal forces and displacements in scaled variables, both of order one: within it a node keeps its state.
ROUNDING = 1e-11
# Weight r of the displacements in the projection. In two dimensions a nodal force moves its node by O(1/E*) against its
# neighbours however fine the mesh, so 1 is the natural scale; it sets the way to the answer, not the answer.
_TRIAL_WEIGHT = 1.0
# Factorised matrices kept: a cycle meets the same sets of nodes again and again.
_CACHED = 512


@dataclass(frozen=True, eq=False)
class Layer:
    """Elastic layer between the faces, the penalty method: compliance of each node; zero for the exact law.

    With it gap and slip in the law are those of the layer's inner faces, g + k_n p and s - k_t q.
    """

    normal: Array
    tangential: Array


@dataclass(frozen=True, eq=False)
class InterfaceState:
    """The interface at one instant, and all the history there is. Scaled; each array (n,), read-only.

    `gap` and `slip` are those of the law (inner faces of the layer); pressure and shear are nodal forces.
    """

    time: float
    normal_load: float
    tangential_load: float
    pressure: Array
    shear: Array
    gap: Array
    slip: Array
    state: States
    approach: float
    shift: float

    @property
    def closed(self) -> Mask:
        """Nodes in contact."""
        return self.state != SurfaceState.OPEN


def untouched(height: Array, time: float) -> InterfaceState:
    """The bodies at rest, touching where the gap is least."""
    zero = freeze(np.zeros_like(height))
    gap = height - height.min()
    state = np.where(gap <= ROUNDING, SurfaceState.STICK, SurfaceState.OPEN)
    return InterfaceState(time, 0.0, 0.0, zero, zero, freeze(gap), zero, freeze(state, np.int8), float(height.min()), 0.0)


@dataclass(eq=False)
class ContactProblem:
    """What does not change along a load path. Factorisations are kept; history is not.

    Attributes
    ----------
    interface : compliance of the two bodies, scaled
    height : (n,) initial gap, scaled
    friction : coefficient f
    layer : of the penalty method
    tangential : False where there can be no shear (no friction, or like bodies with no tangential load): that half is then skipped
    max_iterations : of one increment
    work : counts of what was done
    """

    interface: Interface
    height: Array
    friction: float
    layer: Layer
    tangential: bool = True
    max_iterations: int = 100
    work: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self._normal = self.interface.normal + np.diag(self.layer.normal)
        self._tangential = self.interface.tangential + np.diag(self.layer.tangential)
        self._factors: dict[tuple[str, bytes], tuple[Array, Array]] = {}

    def equilibrium(self, history: InterfaceState, time: float, loads: tuple[float, float]) -> tuple[InterfaceState, int]:
        """The state at `loads` that follows `history` in one increment, and the iterations it took.

        Raises
        ------
        ConvergenceError
            With instant, loads and the number of nodes still changing.
        """
        states = history.state
        seen: set[bytes] = set()
        changing = 0
        for iteration in range(1, self.max_iterations + 1):
            answer = self._with_states(states, history, time, loads)
            trial_pressure = answer.pressure - _TRIAL_WEIGHT * answer.gap
            trial_shear = answer.shear + _TRIAL_WEIGHT * (answer.slip - history.slip)
            wanted = self._wanted(states, trial_pressure, trial_shear)
            changing = int(np.count_nonzero(wanted != states))
            self.work["slip iterations"] += bool(np.any(slip_sign(wanted) != slip_sign(states)))
            if not changing:
                self.work["contact iterations"] += iteration
                return answer, iteration
            # A set met before means a loop: from then on the worst node alone changes, which breaks it.
            if wanted.tobytes() in seen:
                wanted = _worst_only(states, wanted, answer, self.friction, history)
            seen.add(wanted.tobytes())
            states = wanted
        raise ConvergenceError(
            f"contact: {changing} nodes still change state after {self.max_iterations} iterations at time {time:.6g}, "
            f"normal load {loads[0]:.6g}, tangential load {loads[1]:.6g} (over the largest normal load)"
        )

    def holding(self, history: InterfaceState, time: float, loads: tuple[float, float]) -> InterfaceState:
        """The state at `loads` if no node touched, let go, or changed between stick and slip."""
        return self._with_states(history.state, history, time, loads)

    def _wanted(self, states: States, trial_pressure: Array, trial_shear: Array) -> States:
        # Within rounding of touching or of the cone a node keeps the state it has.
        closed = np.where(np.abs(trial_pressure) <= ROUNDING, states != SurfaceState.OPEN, trial_pressure > 0)
        pressure, _, wanted = project(np.maximum(trial_pressure, ROUNDING), trial_shear, self.friction)
        at_cone = np.abs(np.abs(trial_shear) - self.friction * pressure) <= ROUNDING
        wanted = np.where(at_cone & (states != SurfaceState.OPEN), states, wanted)
        wanted = np.where(closed, wanted, SurfaceState.OPEN)
        # A sliding node that turns round sticks first: from forward to reverse slip at one go, sets chase each other.
        wanted = np.where(slip_sign(wanted) * slip_sign(states) < 0, SurfaceState.STICK, wanted)
        if not self.tangential:
            wanted = np.where(wanted == SurfaceState.OPEN, SurfaceState.OPEN, SurfaceState.STICK)
        elif not np.any(wanted == SurfaceState.STICK):
            # Short of gross sliding, which the path is checked for beforehand, some node sticks: the most pressed one is tried.
            wanted[np.argmax(trial_pressure)] = SurfaceState.STICK
        return wanted.astype(np.int8)

    def _with_states(self, states: States, history: InterfaceState, time: float, loads: tuple[float, float]) -> InterfaceState:
        """Forces that meet the equalities of the given states (the linear step of the active set)."""
        closed = states != SurfaceState.OPEN
        solve = self._uncoupled if self.interface.coupling is None or not self.tangential else self._coupled
        pressure, shear, approach, shift = solve(states, closed, history.slip, loads)
        gap = self.height - approach + self._normal @ pressure
        slip = shift - self._tangential @ shear
        if self.interface.coupling is not None:
            gap -= self.interface.coupling.T @ shear
            slip += self.interface.coupling @ pressure
        self.work["linear solves"] += 1
        arrays = (freeze(pressure), freeze(shear), freeze(gap), freeze(slip), freeze(states, np.int8))
        return InterfaceState(time, *loads, *arrays, approach, shift)

    def _uncoupled(
        self, states: States, closed: Mask, slip_before: Array, loads: tuple[float, float]
    ) -> tuple[Array, Array, float, float]:
        """Normal problem first, then the tangential one at known pressure."""
        pressure, approach = self._bordered("normal", self._normal, closed, -self.height, loads[0])
        if not self.tangential:
            return pressure, np.zeros_like(pressure), approach, 0.0
        stick = states == SurfaceState.STICK
        sliding = slip_sign(states) * self.friction * pressure
        known = -slip_before - self._tangential @ sliding
        held, shift = self._bordered("tangential", self._tangential, stick, known, loads[1] - float(sliding.sum()))
        return pressure, held + sliding, approach, shift

    def _bordered(self, name: str, matrix: Array, active: Mask, known: Array, total: float) -> tuple[Array, float]:
        """Forces f on the active nodes and rigid displacement d with matrix f - d = known there, sum f = total."""
        key = (name, active.tobytes())
        if key not in self._factors:
            self._factors[key] = self._factorise(matrix[np.ix_(active, active)])
            self.work["factorisations"] += 1
            if len(self._factors) > _CACHED:
                del self._factors[next(iter(self._factors))]
        factor, by_one = self._factors[key]
        by_known = cho_solve((factor, True), known[active], check_finite=False)
        displacement = (total - float(by_known.sum())) / float(by_one.sum())
        forces = np.zeros(len(active))
        forces[active] = by_known + displacement * by_one
        return forces, displacement

    @staticmethod
    def _factorise(matrix: Array) -> tuple[Array, Array]:
        try:
            factor, _ = cho_factor(matrix, lower=True, check_finite=False)
        except LinAlgError as reason:
            raise ConvergenceError(f"contact: the compliance of the active nodes is not positive definite: {reason}") from reason
        return factor, cho_solve((factor, True), np.ones(len(matrix)), check_finite=False)

    def _coupled(
        self, states: States, closed: Mask, slip_before: Array, loads: tuple[float, float]
    ) -> tuple[Array, Array, float, float]:
        """Normal and tangential problem in one system; unknowns: p of closed nodes, q of sticking ones, approach, shift."""
        coupling = self.interface.coupling
        if coupling is None:
            raise ValueError("like bodies have no coupled system")
        stick = states == SurfaceState.STICK
        traction = slip_sign(states) * self.friction  # q = traction * p where a node slides
        by_pressure = self._normal - coupling.T * traction  # gap by p, sliding nodes taking their q along
        slip_by_pressure = coupling - self._tangential * traction
        n, m = int(closed.sum()), int(stick.sum())
        matrix = np.zeros((n + m + 2, n + m + 2))
        matrix[:n, :n] = by_pressure[np.ix_(closed, closed)]
        matrix[:n, n : n + m] = -coupling.T[np.ix_(closed, stick)]
        matrix[:n, n + m] = -1.0
        matrix[n : n + m, :n] = slip_by_pressure[np.ix_(stick, closed)]
        matrix[n : n + m, n : n + m] = -self._tangential[np.ix_(stick, stick)]
        matrix[n : n + m, n + m + 1] = 1.0
        matrix[n + m, :n] = 1.0
        matrix[n + m + 1, :n] = traction[closed]
        matrix[n + m + 1, n : n + m] = 1.0
        right = np.concatenate([-self.height[closed], slip_before[stick], loads])
        key = ("coupled", states.tobytes())
        if key not in self._factors:
            self._factors[key] = lu_factor(matrix, check_finite=False)
            self.work["factorisations"] += 1
            if len(self._factors) > _CACHED:
                del self._factors[next(iter(self._factors))]
        found = lu_solve(self._factors[key], right, check_finite=False)
        pressure, shear = np.zeros(len(states)), np.zeros(len(states))
        pressure[closed] = found[:n]
        shear[stick] = found[n : n + m]
        return pressure, shear + traction * pressure, float(found[n + m]), float(found[n + m + 1])


def _worst_only(states: States, wanted: States, answer: InterfaceState, friction: float, history: InterfaceState) -> States:
    """`states` with the one change of `wanted` that mends the largest violation."""
    increment = answer.slip - history.slip
    wrong = np.where(states == SurfaceState.OPEN, -answer.gap, -answer.pressure)
    cone = np.abs(answer.shear) - friction * answer.pressure
    backwards = -slip_sign(states) * increment
    violation = np.maximum(wrong, np.where(states == SurfaceState.STICK, cone, backwards))
    violation[wanted == states] = -np.inf
    single = states.copy()
    single[np.argmax(violation)] = wanted[np.argmax(violation)]
    return single
