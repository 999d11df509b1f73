"""Active set (semismooth Newton): contact and friction of two condensed bodies at one load, the law
met at every node.

All in scaled variables: lengths over the half-width, forces over the largest load P, displacements
over P/E*.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from halfplane_fe.arrays import Array, Mask, States
from halfplane_fe.interface import Interface
from halfplane_fe.law import project, slip_sign
from halfplane_fe.systems import Layer, SingularSet, Systems
from halfplane_fe.tresca import pressure_at_known_shear, shear_at_known_pressure
from scenes import OPEN, STICK, ConvergenceError, InputError, freeze

# Rounding of nodal forces and displacements in scaled variables, both of order one: within it a
# node keeps its state.
ROUNDING = 1e-11
# Stiffness against tilt, scaled, that is rounding: of two nodes it is the square of their distance.
_LEAST_STIFFNESS = 1e-12
# Rounding of one node's force, against zero or the cone: it is a hundredth of the load and less, of
# which the laws are met to 1e-9.
_LEAST_FORCE = 1e-13

# Force or gap that is the last digit of an answer, and not left by an event.
_LAST_DIGIT = 1e-15
# Bytes of rates that are kept: a cycle meets the same sets of nodes again.
_RATE_BYTES = 200_000_000

_RIGID, _NODAL = ("approach", "shift", "tilt"), ("slip", "pressure", "shear", "gap")


def nodal(values: Array) -> Array:
    """(4, ..., n) slip, pressure, shear and gap of the nodes, from (..., 3 + 4 n) values of
    interface states: a view.
    """
    parts = values[..., 3:].reshape(*values.shape[:-1], 4, -1)
    return parts if values.ndim == 1 else np.moveaxis(parts, -2, 0)


def _rigid(number: int) -> property:
    return property(lambda state: float(state.values[number]))


def _of_nodes(number: int) -> property:
    return property(lambda state: state.values[3:].reshape(-1, len(state.state))[number])


@dataclass(frozen=True, eq=False)
class InterfaceState:
    """The interface at one instant, and all the history there is. Scaled; each array read-only.

    Attributes
    ----------
    time : of the instant
    loads : P and Q, or the five of `path` where it has bulk stress or tilt
    values : (3 + 4 n,) approach, shift and tilt of the upper body, then slip, pressure, shear and
        gap of the nodes. Gap and slip are those of the law (inner faces of the layer), pressure and
        shear nodal forces, the tilt is given or found from the moment. A state that a long run has
        dropped (`run.PathRun`) ends after the slip
    state : (n,) SurfaceState of each node
    """

    time: float
    loads: tuple[float, ...]
    values: Array
    state: States

    approach, shift, tilt = (_rigid(number) for number in range(3))
    slip, pressure, shear, gap = (_of_nodes(number) for number in range(4))

    @property
    def normal_load(self) -> float:
        """P."""
        return self.loads[0]

    @property
    def tangential_load(self) -> float:
        """Q."""
        return self.loads[1]

    @property
    def whole(self) -> bool:
        """Whether forces and gap are still there."""
        return len(self.values) > 3 + len(self.state)

    @property
    def closed(self) -> Mask:
        """Nodes in contact."""
        return self.state != OPEN

    @property
    def imposed(self) -> Array:
        """(3,) the bulk stresses and the tilt: e of `interface`."""
        return np.array([*self.loads[2:4], self.tilt]) if len(self.loads) > 2 else np.zeros(3)

    def changed(self, *, state: ArrayLike | None = None, **parts: ArrayLike) -> InterfaceState:
        """The same but for some of its values, by name, or its states."""
        values = self.values.copy()
        for name, part in parts.items():
            if name in _RIGID:
                values[_RIGID.index(name)] = part
            else:
                nodal(values)[_NODAL.index(name)] = part
        return replace(
            self,
            values=freeze(values),
            state=self.state if state is None else freeze(state, np.int8),
        )


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
    tangential : False where there can be no shear (no friction, or like bodies with no tangential
    load): that half is then skipped augmentation : weights r_n, r_t of gap and slip in the trial
    tractions, one or (n,) each; they set the way to the answer,
        not the answer. In two dimensions a nodal force moves its node by O(1/E*) against its
        neighbours however fine the mesh, so 1 is natural
    max_iterations : of one increment
    moment_given : whether the fifth load is the moment, so that the tilt follows from it, or the
    tilt itself work : counts of what was done
    jumps : increments in which the interface went from one solution to another, see
        `stepping.follow`
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
        self._rates: dict[bytes, Array] = {}
        # The latest history and states, and what the one lacks of the others.
        self._latest: tuple[tuple[InterfaceState, bytes] | None, Array | float] = None, 0.0
        # Shear and slip of like bodies are in proportion to f, and their rounding with them.
        coupled = self.tangential and self.interface.coupling is not None
        self._share = 1.0 if coupled else min(1.0, self.friction)
        self._last_digit = _LAST_DIGIT * np.repeat([1.0, self._share], len(self.height))

    @cached_property
    def _systems(self) -> Systems:
        """Made when it is first used: of faces that are solved on one half, that half has its
        own.
        """
        return Systems(self.interface, self.layer, self.friction, self.work, self.tangential)

    def at_rest(
        self, time: float = 0.0, loads: tuple[float, ...] = (0.0, 0.0), line: float = 0.0
    ) -> InterfaceState:
        """The bodies before they carry anything, touching where the gap is least, with the bulk
        stresses that there are.

        Of a given moment the tilt is that at which the faces touch on both sides of x = `line`, the
        first place of the resultant.
        """
        tilt = (
            0.0 if len(loads) == 2 else self._resting_tilt(line) if self.moment_given else loads[4]
        )
        gap, slip = self.offsets(np.array([*loads[2:4], tilt] if loads[2:] else np.zeros(3)))
        gap, none = self.height + gap, np.zeros_like(self.height)
        approach = float((gap / self.interface.normals[1]).min())
        nearer, along = self.interface.moved(approach, 0.0)
        values = np.concatenate([[approach, 0.0, tilt], slip + along, none, none, gap + nearer])
        states = np.where(gap + nearer <= ROUNDING, STICK, OPEN)
        return InterfaceState(time, (0.0, 0.0, *loads[2:]), freeze(values), freeze(states, np.int8))

    def equilibrium(
        self, history: InterfaceState, time: float, loads: tuple[float, ...]
    ) -> tuple[InterfaceState, int]:
        """The state at `loads` that follows `history` in one increment (active set), and its
        iterations.

        Raises
        ------
        ConvergenceError
            With instant, loads and the number of nodes still changing.

        >>> springs, none = np.eye(2), np.zeros(2)  # two nodes, each on a spring of its own
        >>> flat = Interface(
        ...     np.array([0.0, 1.0]),
        ...     np.ones(2),
        ...     np.array([[0.0, 0.0], [1.0, 1.0]]),
        ...     none,
        ...     springs,
        ...     springs,
        ...     None,
        ... )
        >>> problem = ContactProblem(flat, np.array([0.0, 1.0]), 0.5, Layer(none, none))
        >>> pressed, _ = problem.equilibrium(problem.at_rest(), 1.0, (3.0, 0.0))
        >>> sheared, _ = problem.equilibrium(pressed, 2.0, (3.0, 1.2))
        >>> (
        ...     pressed.pressure.tolist(),
        ...     sheared.shear.round(12).tolist(),
        ...     sheared.state.tolist(),
        ... )  # the second node slips at f p
        ([2.0, 1.0], [0.7, 0.5], [1, 2])
        """
        answer, iterations, changing = self._active_set(history, time, loads)
        if answer is None and (self.tangential or self.moment_given):
            answer, more, changing = self._alternating(history, time, loads)
            iterations += more
        self.work["contact iterations"] += iterations
        if answer is None:
            raise ConvergenceError(
                f"contact: {changing} nodes still change state after {iterations} iterations at"
                f" time {time:.6g}, normal load {loads[0]:.6g}, tangential load {loads[1]:.6g}"
                " (over the largest normal load)"
            )
        return answer, iterations

    def following(
        self, history: InterfaceState, time: float, loads: tuple[float, ...], states: States
    ) -> InterfaceState:
        """The state at `loads` that follows `history` if its nodes have these states (the linear
        step of the active set).

        Raises
        ------
        SingularSet
            If the states leave the bodies free to move.
        """
        lacking, rates = self._lacking(history, states), self.rates(states, len(loads))
        values = history.values + lacking + np.subtract(loads, history.loads) @ rates
        # what nodes lacked adds to the moment: turning the upper body takes it away
        if self.moment_given and len(loads) > 2:
            values += (loads[4] - self._moments(values)) * rates[4]
        # To the last digit.
        slip, pressure, shear, gap = nodal(values)
        sticks, is_open = (states == STICK) & self.tangential, states == OPEN
        slip[sticks], pressure[is_open], gap[~is_open] = history.slip[sticks], 0.0, 0.0
        shear[:] = np.where(sticks, shear, slip_sign(states) * self.friction * pressure)
        values.flags.writeable = False
        return InterfaceState(time, loads, values, freeze(states, np.int8))

    def rates(self, states: States, n_loads: int) -> Array:
        """(n_loads, 3 + 4 n) derivatives of the values by the loads while the nodes keep their
        states: kept, if there is room.
        """
        if (found := self._rates.get(states.tobytes())) is None:
            found = self._kept_rates(states, self._systems.answers(states, n_loads))
        return found

    def _kept_rates(self, states: States, by_load: Array) -> Array:
        self.work["rates"] += 1
        if self.moment_given and len(by_load) > 2:
            moments = self._moments(by_load)
            if not moments[4] < -_LEAST_STIFFNESS:
                raise SingularSet("one node alone holds no moment")
            by_load = by_load - np.outer([*moments[:4], moments[4] - 1], by_load[4]) / moments[4]
        if len(self._rates) * by_load.nbytes > _RATE_BYTES:
            self._rates.pop(next(iter(self._rates)))
        return self._rates.setdefault(states.tobytes(), by_load)

    def _lacking(self, history: InterfaceState, states: States) -> Array | float:
        """(3 + 4 n,) what `history` lacks of the equalities of states: of nodes that change sides,
        or did so in an event.
        """
        key = history, states.tobytes()
        if self._latest[0] == key:
            return self._latest[1]
        _, pressure, shear, gap = nodal(history.values)
        slide = shear - slip_sign(states) * self.friction * pressure
        lacking = np.concatenate(
            [np.where(states == OPEN, pressure, gap), np.where(states == STICK, 0.0, slide)]
        )
        rows = np.flatnonzero(np.abs(lacking) > self._last_digit)
        lacks: Array | float = 0.0
        if len(rows):
            found = self._systems.answers(states, len(history.loads), rows, -lacking[rows])
            if key[1] not in self._rates:
                self._kept_rates(states, found[:-1].copy())
            lacks = found[-1]
        self._latest = key, lacks
        return lacks

    def _active_set(
        self, history: InterfaceState, time: float, loads: tuple[float, ...]
    ) -> tuple[InterfaceState | None, int, int]:
        """Semismooth Newton: states -> forces that meet them -> states that these want, until they
        agree.

        The first step is by the rates of the states that the history has. From an answer under load
        it is the answer where none of them changes.
        """
        seen: set[bytes] = set()
        changing, before = 0, slip_sign(history.state)
        try:
            states = history.state
            for iteration in range(self.max_iterations + 1):
                answer = self.following(history, time, loads, states)
                wanted = self._wanted(answer, history)
                changing = int(np.count_nonzero(wanted != states))
                self.work["slip iterations"] += iteration > 0 and not np.array_equal(
                    slip_sign(wanted), before
                )
                if not changing:
                    return answer, max(iteration, 1), 0
                if wanted.tobytes() in seen:
                    return None, iteration, changing
                if iteration:
                    seen.add(wanted.tobytes())
                states = wanted
        except SingularSet:
            return None, max(len(seen), 1), changing
        return None, self.max_iterations, changing

    def _alternating(
        self, history: InterfaceState, time: float, loads: tuple[float, ...]
    ) -> tuple[InterfaceState | None, int, int]:
        """Where Newton's sets chase each other: pressure at known shear, then shear at known
        pressure, by turns.

        Both halves are convex, and coupling times friction is small, so the turns converge; as soon
        as their states agree with themselves in the whole system, that system's answer is taken.
        Like bodies need one turn.
        """
        self.work["alternating solves"] += 1
        coupling = (
            np.zeros_like(self.interface.normal)
            if self.interface.coupling is None
            else self.interface.coupling
        )
        n_x = self.interface.normals[0]
        shear, shift, closed, changing = history.shear, history.shift, history.closed, 0
        imposed = replace(history, loads=loads).imposed
        if len(loads) > 2 and not self.moment_given:
            imposed[2] = loads[4]
        for turn in range(1, self.max_iterations + 1):
            systems, height = self._systems, self.height - coupling.T @ shear + n_x * shift
            if self.moment_given:
                imposed[2] = self._tilt_at_known_shear(height, shear, closed, imposed, loads)
            height = height + self.offsets(imposed)[0]
            pressure, approach, closed = pressure_at_known_shear(
                systems, height, loads[0] - float(n_x @ shear), closed, ROUNDING
            )
            known_slip = (
                history.slip - self.offsets(imposed)[1] - coupling @ pressure - n_x * approach
            )
            load = loads[1] + float(n_x @ pressure)
            carried = None if self.interface.guided else load
            states = np.where(closed, STICK, OPEN).astype(np.int8)
            if self.tangential:
                pressed = np.maximum(pressure, 0.0)
                shear, shift, states = shear_at_known_pressure(
                    systems, pressed, known_slip, carried, ROUNDING
                )
            if not np.any(states == STICK):
                continue
            answer = self.following(history, time, loads, states)
            changing = int(np.count_nonzero(self._wanted(answer, history) != states))
            if not changing:
                return answer, turn, 0
        return None, self.max_iterations, changing

    def _wanted(self, answer: InterfaceState, history: InterfaceState) -> States:
        """The states that the law gives the answer's nodes."""
        states, (slip, pressure, shear, gap) = answer.state, nodal(answer.values)
        is_open, sticks = states == OPEN, states == STICK
        # What the equations of these states set to zero counts as zero: weighted, its rounding
        # would look like a force.
        gap, slip = np.where(is_open, gap, 0.0), np.where(sticks, 0.0, slip - history.slip)
        r_normal, r_tangential = self.augmentation
        trial = pressure - r_normal * gap
        # Within rounding of touching or of the cone a node keeps the state it has.
        touching = (np.abs(pressure) <= _LEAST_FORCE) & (np.abs(gap) <= ROUNDING)
        closed = np.where(touching, ~is_open, trial > 0)
        if not self.tangential:
            return np.where(closed, STICK, OPEN).astype(np.int8)
        limit, _, wanted = project(
            np.maximum(trial, ROUNDING), shear + r_tangential * slip, self.friction
        )
        at_cone = np.abs(np.abs(shear) - self.friction * limit) <= _LEAST_FORCE * self._share
        at_cone &= (np.abs(slip) <= ROUNDING * self._share) & ~is_open
        wanted = np.where(closed, np.where(at_cone, states, wanted), OPEN)
        # A sliding node that turns round sticks first: from forward to reverse slip at one go, sets
        # chase each other.
        turned = (wanted != states) & (wanted > STICK) & (states > STICK)
        return np.where(turned, STICK, wanted).astype(np.int8)

    def _tilt_at_known_shear(
        self, height: Array, shear: Array, closed: Mask, imposed: Array, loads: tuple[float, ...]
    ) -> float:
        """The tilt at which the pressure over `height` and the shear have the moment given; the
        larger it is, the less is M.
        """
        load = loads[0] - float(self.interface.normals[0] @ shear)

        def excess(tilt: float) -> float:
            over = height + self.offsets(np.array([*imposed[:2], tilt]))[0]
            pressure = pressure_at_known_shear(self._systems, over, load, closed, ROUNDING)[0]
            return -float(self.interface.work_of_imposed(pressure, shear)[2]) - loads[4]

        middle, most = (
            float(imposed[2]),
            float(np.ptp(self.height)) / float(np.ptp(self.interface.x)),
        )
        for width in most * 2.0 ** np.arange(-10, 30):
            if excess(middle - width) >= 0 >= excess(middle + width):
                return float(
                    brentq(excess, middle - width, middle + width, xtol=1e-15 * width, rtol=8.9e-16)
                )
        raise ConvergenceError(
            f"contact: no tilt has the moment {loads[4]:.6g} (scaled): its line of action misses"
            " the faces"
        )

    def _resting_tilt(self, line: float) -> float:
        """The tilt of a plane laid onto the gap that touches on both sides of x = `line`: its lower
        convex hull there, turned.
        """
        gap, n_y = self.offsets(np.array([0.0, 0.0, 1.0]))[0], self.interface.normals[1]
        x, height = gap / n_y, self.height / n_y
        if not x[0] < line < x[-1]:
            raise BesideTheFaces(
                "load: the upper body falls over: its line of action meets the faces beside where"
                " they can touch; take a smaller moment, or wider bodies"
            )
        left, right = np.flatnonzero(x <= line), np.flatnonzero(x > line)
        slopes = np.subtract.outer(height[right], height[left]) / np.subtract.outer(
            x[right], x[left]
        )
        # The height at `line` of the chord between each pair; the lowest chord is the hull's.
        at = height[left] + slopes * (line - x[left])
        return -float(slopes.flat[np.argmin(at)])

    def offsets(self, imposed: Array) -> tuple[Array, Array]:
        """What bulk stresses and tilt (..., 3) add to gap and slip, each (..., n)."""
        if self.interface.imposed is None or not imposed.any():
            return np.zeros_like(self.height), np.zeros_like(self.height)
        gap, slip = np.moveaxis(np.tensordot(imposed, self.interface.imposed, (-1, -1)), -2, 0)
        return gap, slip

    def _moments(self, values: Array) -> Array:
        """(...) of the forces in values (..., 3 + 4 n)."""
        return np.asarray(-self.interface.work_of_imposed(*nodal(values)[1:3])[..., 2])
