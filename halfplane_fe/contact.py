"""Active set (semismooth Newton): contact and friction of two condensed bodies at one load, the law met at every node.

All in scaled variables: lengths over the half-width, forces over the largest load P, displacements over P/E*.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from halfplane_fe.active_subsets import SingularSet
from halfplane_fe.interface import Interface
from halfplane_fe.law import project, slip_sign
from halfplane_fe.systems import Forces, Layer, Systems
from halfplane_fe.tresca import pressure_at_known_shear, shear_at_known_pressure
from scenes import OPEN, STICK, ConvergenceError, InputError, freeze

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
States = NDArray[np.int8]

# Rounding of nodal forces and displacements in scaled variables, both of order one: within it a node keeps its state.
ROUNDING = 1e-11
# Stiffness against tilt, scaled, that is rounding: of two nodes it is the square of their distance.
_LEAST_STIFFNESS = 1e-12
# Rounding of one node's force, against zero or the cone: it is a hundredth of the load and less, of which the laws are met to 1e-9.
_LEAST_FORCE = 1e-12


@dataclass(frozen=True, eq=False)
class InterfaceState:
    """The interface at one instant, and all the history there is. Scaled; each array (n,), read-only.

    `gap` and `slip` are those of the law (inner faces of the layer); pressure and shear are nodal forces. `tilt` is that of the
    upper body, given or found from the moment; `further` are the three loads of a path with bulk stress or tilt beside P and Q.
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
    tilt: float = 0.0
    further: tuple[float, ...] = ()

    @property
    def closed(self) -> Mask:
        """Nodes in contact."""
        return self.state != OPEN

    @property
    def loads(self) -> tuple[float, ...]:
        """P and Q, or the five of `path`."""
        return self.normal_load, self.tangential_load, *self.further

    @property
    def imposed(self) -> Array:
        """(3,) the bulk stresses and the tilt: e of `interface`."""
        return np.array([*self.further[:2], self.tilt]) if self.further else np.zeros(3)


def untouched(height: Array, time: float) -> InterfaceState:
    """The bodies at rest, touching where the gap is least."""
    zero = freeze(np.zeros_like(height))
    gap = height - height.min()
    state = np.where(gap <= ROUNDING, STICK, OPEN)
    return InterfaceState(time, 0.0, 0.0, zero, zero, freeze(gap), zero, freeze(state, np.int8), float(height.min()), 0.0)


class Rate(NamedTuple):
    """The interface as its fields: derivatives by a load, or values."""

    pressure: Array
    shear: Array
    approach: float
    shift: float
    gap: Array
    slip: Array
    tilt: float


class BesideTheFaces(InputError):
    """The line of action of the loads does not meet the side that may touch."""


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
    augmentation : weights r_n, r_t of gap and slip in the trial tractions, one or (n,) each; they set the way to the answer,
        not the answer. In two dimensions a nodal force moves its node by O(1/E*) against its neighbours however fine the mesh,
        so 1 is natural
    max_iterations : of one increment
    moment_given : whether the fifth load is the moment, so that the tilt follows from it, or the tilt itself
    work : counts of what was done
    jumps : increments in which the interface went from one solution to another, see `stepping.follow`
    """

    interface: Interface
    height: Array
    friction: float
    layer: Layer
    tangential: bool = True
    max_iterations: int = 100
    augmentation: tuple[Array | float, Array | float] = (1.0, 1.0)
    moment_given: bool = False
    work: Counter[str] = field(default_factory=Counter)
    jumps: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._systems = Systems(self.interface, self.layer, self.friction, self.work)
        self._rates: tuple[bytes, dict[int, Rate]] = (b"", {})
        self._by_tilt: tuple[bytes, Rate] | tuple[None, None] = (None, None)
        self._coupled = self.tangential and self.interface.coupling is not None
        # Shear and slip of like bodies are in proportion to f, and their rounding with them.
        self._share = 1.0 if self._coupled else min(1.0, self.friction)

    def at_rest(self, time: float, loads: tuple[float, ...], line: float) -> InterfaceState:
        """The bodies before they carry anything, with the bulk stresses that there are.

        Of a given moment the tilt is that at which the faces touch on both sides of x = `line`, the first place of the resultant.
        """
        if len(loads) == 2:
            return untouched(self.height, time)
        tilt = self._resting_tilt(line) if self.moment_given else loads[4]
        gap, slip = self.offsets(np.array([*loads[2:4], tilt]))
        approach = float(((self.height + gap) / self.interface.normals[1]).min())
        nearer, along = self.interface.moved(approach, 0.0)
        rest = untouched(self.height + gap + nearer, time)
        return replace(rest, slip=freeze(slip + along), approach=approach, tilt=tilt, further=loads[2:])

    def equilibrium(self, history: InterfaceState, time: float, loads: tuple[float, ...]) -> tuple[InterfaceState, int]:
        """The state at `loads` that follows `history` in one increment (active set), and its iterations.

        Raises
        ------
        ConvergenceError
            With instant, loads and the number of nodes still changing.

        >>> springs, none = np.eye(2), np.zeros(2)  # two nodes, each on a spring of its own
        >>> flat = Interface(np.array([0.0, 1.0]), np.ones(2), np.array([[0.0, 0.0], [1.0, 1.0]]), none, springs, springs, None)
        >>> problem = ContactProblem(flat, np.array([0.0, 1.0]), 0.5, Layer(none, none))
        >>> pressed, _ = problem.equilibrium(untouched(problem.height, 0.0), 1.0, (3.0, 0.0))
        >>> sheared, _ = problem.equilibrium(pressed, 2.0, (3.0, 1.2))
        >>> pressed.pressure.tolist(), sheared.shear.round(12).tolist(), sheared.state.tolist()  # the second node slips at f p
        ([2.0, 1.0], [0.7, 0.5], [1, 2])
        """
        answer, iterations, changing = self._active_set(history, time, loads)
        if answer is None and (self.tangential or self.moment_given):
            answer, more, changing = self._alternating(history, time, loads)
            iterations += more
        self.work["contact iterations"] += iterations
        if answer is None:
            raise ConvergenceError(
                f"contact: {changing} nodes still change state after {iterations} iterations at time {time:.6g}, "
                f"normal load {loads[0]:.6g}, tangential load {loads[1]:.6g} (over the largest normal load)"
            )
        return answer, iterations

    def holding(self, history: InterfaceState, time: float, loads: tuple[float, ...]) -> InterfaceState:
        """The state at `loads` if no node touched, let go, or changed between stick and slip: `history` plus its rates."""
        change = np.subtract(loads, history.loads).tolist()
        moving = [number for number, by in enumerate(change) if by or number < 2]
        by_load = self.rates(history.state, len(loads), moving)
        moved = {
            name: getattr(history, name) + sum(change[number] * getattr(by_load[number], name) for number in moving)
            for name in Rate._fields
        }
        return InterfaceState(time, loads[0], loads[1], **moved, state=history.state, further=loads[2:])

    def rates(self, states: States, n_loads: int, wanted: Iterable[int]) -> dict[int, Rate]:
        """Derivatives of the interface by those loads while the nodes keep their states; of the last states they are kept."""
        if states.tobytes() != self._rates[0]:
            self._rates = states.tobytes(), {}
            self.work["rates"] += 1
        found, none = self._rates[1], np.zeros_like(self.height)
        for number in set(wanted) - found.keys():
            loads = tuple(float(number == other) for other in range(n_loads))
            try:
                found[number] = self._values(states, none, none, loads)
            except SingularSet:
                if not self.moment_given:
                    raise
                # One node is left: the upper body rolls over it, to where another touches. Nothing foresees it.
                found[number] = Rate(none, none, 0.0, 0.0, none, none, 0.0)
        return found

    def _active_set(self, history: InterfaceState, time: float, loads: tuple[float, ...]) -> tuple[InterfaceState | None, int, int]:
        """Semismooth Newton: states -> forces that meet them -> states that these want, until they agree.

        The first step is by the rates of the states that the history has. From an answer under load it is the answer where none of
        them changes.
        """
        seen: set[bytes] = set()
        changing, states = 0, history.state
        try:
            held = self.holding(history, time, loads)
            states = self._wanted(held, history)
            # A node that an event has put on its new side keeps what was left there of its force or gap: that takes a solution.
            left = np.where(history.closed, history.gap, history.pressure)
            met = history.pressure.any() and np.abs(left).max() <= _LEAST_FORCE
            if met and np.array_equal(states, history.state) and not self.moment_given:
                self.work["slip iterations"] += 0
                # On the cone to the last digit, as an answer of the equations is.
                pressure = np.where(states == OPEN, 0.0, held.pressure)
                shear = np.where(states == STICK, held.shear, slip_sign(states) * self.friction * pressure)
                return replace(held, pressure=freeze(pressure), shear=freeze(shear)), 1, 0
            for iteration in range(1, self.max_iterations + 1):
                answer = self._with_states(states, history, time, loads)
                wanted = self._wanted(answer, history)
                changing = int(np.count_nonzero(wanted != states))
                self.work["slip iterations"] += bool(np.any(slip_sign(wanted) != slip_sign(history.state)))
                if not changing:
                    return answer, iteration, 0
                if wanted.tobytes() in seen:
                    return None, iteration, changing
                seen.add(wanted.tobytes())
                states = wanted
        except SingularSet:
            return None, max(len(seen), 1), changing
        return None, self.max_iterations, changing

    def _alternating(
        self, history: InterfaceState, time: float, loads: tuple[float, ...]
    ) -> tuple[InterfaceState | None, int, int]:
        """Where Newton's sets chase each other: pressure at known shear, then shear at known pressure, by turns.

        Both halves are convex, and coupling times friction is small, so the turns converge; as soon as their states agree with
        themselves in the whole system, that system's answer is taken. Like bodies need one turn.
        """
        self.work["alternating solves"] += 1
        coupling = np.zeros_like(self._systems.normal) if self.interface.coupling is None else self.interface.coupling
        n_x = self.interface.normals[0]
        shear, shift, closed, changing = history.shear, history.shift, history.closed, 0
        imposed = replace(history, tilt=history.tilt if self.moment_given else loads[-1], further=loads[2:]).imposed
        for turn in range(1, self.max_iterations + 1):
            systems, height = self._systems, self.height - coupling.T @ shear + n_x * shift
            if self.moment_given:
                imposed[2] = self._tilt_at_known_shear(height, shear, closed, imposed, loads)
            height = height + self.offsets(imposed)[0]
            pressure, approach, closed = pressure_at_known_shear(systems, height, loads[0] - float(n_x @ shear), closed, ROUNDING)
            known_slip = history.slip - self.offsets(imposed)[1] - coupling @ pressure - n_x * approach
            load = loads[1] + float(n_x @ pressure)
            carried = None if self.interface.guided else load
            states = np.where(closed, STICK, OPEN).astype(np.int8)
            if self.tangential:
                pressed = np.maximum(pressure, 0.0)
                shear, shift, states = shear_at_known_pressure(systems, pressed, known_slip, carried, ROUNDING)
            if not np.any(states == STICK):
                continue
            answer = self._with_states(states, history, time, loads)
            changing = int(np.count_nonzero(self._wanted(answer, history) != states))
            if not changing:
                return answer, turn, 0
        return None, self.max_iterations, changing

    def _wanted(self, answer: InterfaceState, history: InterfaceState) -> States:
        """The states that the law gives the answer's nodes."""
        states = answer.state
        # What the equations of these states set to zero counts as zero: weighted, its rounding would look like a force.
        gap = np.where(states == OPEN, answer.gap, 0.0)
        slip = np.where(states == STICK, 0.0, answer.slip - history.slip)
        r_normal, r_tangential = self.augmentation
        trial_pressure = answer.pressure - r_normal * gap
        # Within rounding of touching or of the cone a node keeps the state it has.
        touching = (np.abs(answer.pressure) <= _LEAST_FORCE) & (np.abs(gap) <= ROUNDING)
        closed = np.where(touching, states != OPEN, trial_pressure > 0)
        pressure, _, wanted = project(np.maximum(trial_pressure, ROUNDING), answer.shear + r_tangential * slip, self.friction)
        limit = _LEAST_FORCE * self._share, ROUNDING * self._share
        at_cone = (np.abs(np.abs(answer.shear) - self.friction * pressure) <= limit[0]) & (np.abs(slip) <= limit[1])
        wanted = np.where(at_cone & (states != OPEN), states, wanted)
        wanted = np.where(closed, wanted, OPEN)
        # A sliding node that turns round sticks first: from forward to reverse slip at one go, sets chase each other.
        wanted = np.where(slip_sign(wanted) * slip_sign(states) < 0, STICK, wanted)
        if not self.tangential:
            wanted = np.where(wanted == OPEN, OPEN, STICK)
        return wanted.astype(np.int8)

    def _tilt_at_known_shear(self, height: Array, shear: Array, closed: Mask, imposed: Array, loads: tuple[float, ...]) -> float:
        """The tilt at which the pressure over `height` and the shear have the moment given; the larger it is, the less is M."""
        load = loads[0] - float(self.interface.normals[0] @ shear)

        def excess(tilt: float) -> float:
            over = height + self.offsets(np.array([*imposed[:2], tilt]))[0]
            pressure = pressure_at_known_shear(self._systems, over, load, closed, ROUNDING)[0]
            return self._moment(pressure, shear) - loads[4]

        middle, most = float(imposed[2]), float(np.ptp(self.height)) / float(np.ptp(self.interface.x))
        for width in most * 2.0 ** np.arange(-10, 30):
            if excess(middle - width) >= 0 >= excess(middle + width):
                return float(brentq(excess, middle - width, middle + width, xtol=1e-15 * width, rtol=8.9e-16))
        raise ConvergenceError(f"contact: no tilt has the moment {loads[4]:.6g} (scaled): its line of action misses the faces")

    def _resting_tilt(self, line: float) -> float:
        """The tilt of a plane laid onto the gap that touches on both sides of x = `line`: its lower convex hull there, turned."""
        gap, n_y = self.offsets(np.array([0.0, 0.0, 1.0]))[0], self.interface.normals[1]
        x, height = gap / n_y, self.height / n_y
        if not x[0] < line < x[-1]:
            raise BesideTheFaces(
                "load: the upper body falls over: its line of action meets the faces beside where they can touch; take a smaller "
                "moment, or wider bodies"
            )
        left, right = np.flatnonzero(x <= line), np.flatnonzero(x > line)
        slopes = np.subtract.outer(height[right], height[left]) / np.subtract.outer(x[right], x[left])
        # The height at `line` of the chord between each pair; the lowest chord is the hull's.
        at = height[left] + slopes * (line - x[left])
        return -float(slopes.flat[np.argmin(at)])

    def offsets(self, imposed: Array) -> tuple[Array, Array]:
        """What bulk stresses and tilt (3,) add to gap and slip, each (n,)."""
        if self.interface.imposed is None:
            return np.zeros_like(self.height), np.zeros_like(self.height)
        gap, slip = self.interface.imposed @ imposed
        return gap, slip

    def _moment(self, pressure: Array, shear: Array) -> float:
        """Moment of nodal forces."""
        return -float(self.interface.work_of_imposed(pressure, shear)[2])

    def _with_states(self, states: States, history: InterfaceState, time: float, loads: tuple[float, ...]) -> InterfaceState:
        """Forces that meet the equalities of the given states (the linear step of the active set)."""
        values = self._values(states, self.height, history.slip, loads)
        return InterfaceState(
            time,
            loads[0],
            loads[1],
            freeze(values.pressure),
            freeze(values.shear),
            freeze(values.gap),
            freeze(values.slip),
            freeze(states, np.int8),
            values.approach,
            values.shift,
            values.tilt,
            loads[2:],
        )

    def _values(self, states: States, height: Array, slip: Array, loads: tuple[float, ...]) -> Rate:
        """The interface of given states over an initial gap, sticking nodes at a known slip."""
        if len(loads) == 2:
            forces = self._forces(states, height, slip, loads)
            return Rate(*forces, self._systems.gap(height, forces), self._systems.slip(forces), 0.0)
        tilt = 0.0 if self.moment_given else loads[4]
        gap, along = self.offsets(np.array([*loads[2:4], tilt]))
        forces = self._forces(states, height + gap, slip - along, loads[:2])
        found = Rate(*forces, self._systems.gap(height + gap, forces), self._systems.slip(forces) + along, tilt)
        if not self.moment_given:
            return found
        # The equations are linear: what is missing of the moment comes from turning the upper body.
        turned = self._turned(states)
        tilt = (loads[4] - self._moment(found.pressure, found.shear)) / self._moment(turned.pressure, turned.shear)
        pairs = {name: (getattr(found, name), getattr(turned, name)) for name in Rate._fields}
        return Rate(**{name: one + tilt * by_tilt for name, (one, by_tilt) in pairs.items()})

    def _turned(self, states: States) -> Rate:
        """Derivatives by the tilt at no loads; SingularSet where one node alone holds the upper body."""
        key = states.tobytes()
        if key != self._by_tilt[0]:
            gap, along = self.offsets(np.array([0.0, 0.0, 1.0]))
            forces = self._forces(states, gap, -along, (0.0, 0.0))
            turned = Rate(*forces, self._systems.gap(gap, forces), self._systems.slip(forces) + along, 1.0)
            if not -self._moment(turned.pressure, turned.shear) > _LEAST_STIFFNESS:
                raise SingularSet("one node alone holds no moment")
            self._by_tilt = key, turned
        return self._by_tilt[1]

    def _forces(self, states: States, height: Array, slip: Array, loads: tuple[float, ...]) -> Forces:
        """Forces of given states over an initial gap, sticking nodes at a known slip; `loads` are P and Q."""
        if self._coupled:
            return self._systems.both(states, height, slip, (loads[0], loads[1]))
        pressure, approach = self._systems.pressure_alone(states != OPEN, height, loads[0])
        shear, shift = np.zeros_like(pressure), 0.0
        if self.tangential:
            shear, shift = self._systems.shear_alone(states, pressure, slip, loads[1])
        return Forces(pressure, shear, approach, shift)
