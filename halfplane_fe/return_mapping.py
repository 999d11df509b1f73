r"""Return mapping of tractions: penalty method, and augmented Lagrangian of Simo and Laursen.

The faces carry what the contact law makes of a trial,

    (p, q) = project(l - e g,  m + e ds),

with a penalty e (force over displacement of each node), gap g, slip ds since the start of the
increment, and multipliers l, m. Two loops:

    inner   l and m stay. Newton's method on p - project(...) = 0, q - project(...) = 0 and the
            equilibrium of the loads, on the condensed bodies
    outer   (l, m) = (p, q), until they change no more: then the gap under pressure, the slip of
            what sticks and the force beyond the Coulomb limit are zero

The multipliers start from the tractions of the increment before. In the values of a state that is
iterated, gap and slip are G = g + c (p - l) and S = s - c (q - m), c = 1/e, so that the trial is p
- G/c and q + dS/c. Penalty method: c is the layer between the faces, there is no multiplier, and
one inner loop is all. Where an inner loop cycles, the increment is solved again from the same start
with a softer penalty. Between faces with a layer the softness comes on top of the layer, and its
multipliers take it away again.

Source: Simo and Laursen (1992), Computers and Structures; see `law.project`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from halfplane_fe.actuators import LOADS_ARE_GIVEN, Actuators
from halfplane_fe.interface import Interface
from halfplane_fe.law import project, slip_sign
from halfplane_fe.systems import Layer, SingularSet, Systems
from scenes import OPEN, STICK
from scenes.array_types import Array, States

# Change of multipliers, and what the law makes of the tractions less these, over the largest nodal
# force.
_TOLERANCE = 1e-10
# Where Newton's method cycles, the penalty of the next try over that of the one before.
_PENALTY_RATIO = 0.1
_MOST_PENALTIES = 5
# Of an increment: softer penalties take more of them.
_MOST_UPDATES = 2000
# Pressure of a node that touches without force, from which the sense of its slip is read.
_TOUCHING_PRESSURE = 1e-11


class Tractions(NamedTuple):
    """What is iterated, and what the law makes of it.

    Attributes
    ----------
    trial_pressure, trial_shear
        (n,) before the return mapping
    pressure, shear, states
        (n,) after it
    error
        largest difference of the mapped tractions from the iterated ones, over the tolerance
    """

    trial_pressure: Array
    trial_shear: Array
    pressure: Array
    shear: Array
    states: States
    error: float


class Equilibrium(NamedTuple):
    """The values of an interface state that meet the law, the states of its nodes, and the Newton
    steps that were taken.
    """

    values: Array
    states: States
    newton_steps: int


class Start(NamedTuple):
    """Values (3 + 4 n,) and states (n,) at the start of an increment, and the change of its loads;
    the moment at its end, where it is given.
    """

    values: Array
    states: States
    change_of_loads: Array
    moment: float | None


@dataclass(eq=False)
class ReturnMapping:
    """Equilibrium of two condensed bodies by return mapping; scaled.

    Attributes
    ----------
    interface, friction, layer, tangential, work, actuators
        see `contact.ContactProblem`
    penalty
        (n,) normal and tangential e of the augmented Lagrangian; None for the penalty method,
        whose penalty is the stiffness of the layer
    shear_scale
        of a nodal shear over a nodal pressure
    """

    interface: Interface
    friction: float
    layer: Layer
    tangential: bool
    penalty: tuple[Array, Array] | None
    work: Counter[str]
    shear_scale: float = 1.0
    actuators: Actuators = LOADS_ARE_GIVEN
    _systems: dict[int, Systems] = field(default_factory=dict, init=False)

    def equilibrium(self, start: Start, most_steps: int) -> Equilibrium | None:
        """Nodal values and states of the contact at the end of an increment, by return mapping;
        None where it converges with no penalty.

        Penalties are tried from the stiffest one on, each a tenth of the one before.

        Parameters
        ----------
        start
            values and node states before the increment, and the change of its loads
        most_steps
            most Newton steps at constant multipliers
        """
        newton_steps = 0
        for number, softness in enumerate(self._softnesses()):
            systems = self._systems_with(number, softness)
            iteration = _Iteration(self, systems, softness, start)
            try:
                has_converged = iteration.converges(most_steps)
            except SingularSet:
                has_converged = False
            newton_steps += iteration.newton_steps
            self.work["Newton steps"] += iteration.newton_steps
            self.work["multiplier updates"] += iteration.updates
            if has_converged:
                return Equilibrium(*iteration.answer(), newton_steps)
            self.work["penalties softened"] += 1
        return None

    def _softnesses(self) -> Iterator[Layer]:
        """Compliances (inverse penalties) of the nodes for the trial tractions, in the order in
        which they are tried, each ten times as soft as the one before.

        The first is that of the augmented Lagrangian's penalty. The penalty method has a layer of
        springs between the faces already: its first is zero.
        """
        if self.penalty is None:
            yield Layer(np.zeros_like(self.layer.normal), np.zeros_like(self.layer.tangential))
            stiffest = self.layer
        else:
            normal_penalty, tangential_penalty = self.penalty
            stiffest = Layer(1 / normal_penalty, 1 / tangential_penalty)
            yield stiffest
        for number in range(1, _MOST_PENALTIES):
            factor = _PENALTY_RATIO**-number
            yield Layer(stiffest.normal * factor, stiffest.tangential * factor)

    def _systems_with(self, number: int, softness: Layer) -> Systems:
        """The linear systems of the contact with a compliance of the nodes, the layer's plus
        `softness`; cached under the `number` of that softness.
        """
        systems = self._systems.get(number)
        if systems is None:
            compliance = Layer(
                self.layer.normal + softness.normal, self.layer.tangential + softness.tangential
            )
            systems = Systems(
                self.interface,
                compliance,
                self.friction,
                self.work,
                self.tangential,
                self.actuators,
            )
            self._systems[number] = systems
        return systems


@dataclass(eq=False)
class _Iteration:
    """Both loops of one increment at one penalty.

    Attributes
    ----------
    faces, systems, softness, start
        what is solved
    values
        (3 + 4 n,) as iterated, G and S in the place of gap and slip
    newton_steps, updates
        counts
    """

    faces: ReturnMapping
    systems: Systems
    softness: Layer
    start: Start
    newton_steps: int = 0
    updates: int = 0

    def __post_init__(self) -> None:
        self.values = self.start.values.copy()
        # views of `values`
        self._slip, self._pressure, self._shear, self._gap = self.values[3:].reshape(4, -1)
        self._slip_at_start = self._slip.copy()
        self._latest_states = self.start.states

    def converges(self, most_steps: int) -> bool:
        """Run both loops of the augmented Lagrangian from the start of the increment; whether they
        converge. The nodal values are left in `self.values`.

        The inner loop is Newton's method at constant multipliers, `most_steps` steps at most. The
        outer loop replaces the multipliers by the tractions found, until these change no more. The
        penalty method has no multipliers: one inner loop is all.

        Raises
        ------
        SingularSet
            If so few nodes hold that the bodies are free to move.
        """
        pressure = self._pressure.copy()
        shear = self._shear.copy()
        tractions_at_start = Tractions(pressure, shear, pressure, shear, self.start.states, np.inf)
        self._newton_step(tractions_at_start, self.start.change_of_loads)
        multipliers = self.start.values[3:].reshape(4, -1)[1:3].copy()  # p and q of the nodes
        without_multipliers = not (self.softness.normal.any() or self.softness.tangential.any())
        while self.updates < _MOST_UPDATES:
            mapped_tractions = self._inner_loop(most_steps)
            if mapped_tractions is None:
                return False
            if without_multipliers:
                return True
            self.updates += 1
            change_of_multipliers = self._updated(multipliers, mapped_tractions)
            if change_of_multipliers <= 1.0 and self._mapped().error <= 1.0:
                return True
        return False

    def _inner_loop(self, most_steps: int) -> Tractions | None:
        """Newton's method at constant multipliers: the tractions on which it converges; None where
        a set of node states comes back (it would go round for ever), or after `most_steps`.
        """
        sets_met: set[bytes] = set()  # node states of all steps so far
        for _ in range(most_steps):
            mapped_tractions = self._mapped()
            if mapped_tractions.error <= 1.0:
                return mapped_tractions
            states_as_bytes = mapped_tractions.states.tobytes()
            if states_as_bytes in sets_met:
                return None
            sets_met.add(states_as_bytes)
            mapped_tractions = self._with_sticking(mapped_tractions)
            self._newton_step(mapped_tractions, np.zeros_like(self.start.change_of_loads))
        return None

    def _with_sticking(self, mapped_tractions: Tractions) -> Tractions:
        """Let some nodes stick in the next Newton step that are to slide by their trial tractions,
        so that the steps converge; the mapped tractions with their states and shear changed.

        - A node that slides one way and is to slide the other way sticks first: changed at one
          go, it would be changed back.
        - Where all nodes are to slide, the one least beyond the Coulomb limit sticks: Q < f P, so
          one has to.
        """
        is_sliding = mapped_tractions.states > STICK
        is_sticking_first = (
            is_sliding
            & (self._latest_states > STICK)
            & (mapped_tractions.states != self._latest_states)
        )
        nothing_sticks = not np.any((mapped_tractions.states == STICK) | is_sticking_first)
        may_slide_freely = (
            self.faces.interface.has_odd_shear or self.faces.actuators.tangential is not None
        )
        if self.faces.tangential and nothing_sticks and not may_slide_freely:
            force_beyond_limit = (
                np.abs(mapped_tractions.trial_shear)
                - self.faces.friction * mapped_tractions.pressure
            )
            is_sticking_first[np.argmin(np.where(is_sliding, force_beyond_limit, np.inf))] = True
        return mapped_tractions._replace(
            states=np.where(is_sticking_first, STICK, mapped_tractions.states).astype(np.int8),
            shear=np.where(is_sticking_first, mapped_tractions.trial_shear, mapped_tractions.shear),
        )

    def _mapped(self) -> Tractions:
        """Return mapping at the present values of the nodes: trial tractions p - g/c_n and
        q + s/c_t, moved into p >= 0 and |q| <= f p, with the states of the nodes that follow.

        # notation: g gap and s slip of the increment as iterated (with what the multipliers add);
        c_n, c_t compliances of the nodes, the inverse penalties
        """
        compliance = self.systems.layer
        trial_pressure = self._pressure - self._gap / compliance.normal
        trial_shear = self._shear
        if self.faces.tangential:
            slip_increment = self._slip - self._slip_at_start
            trial_shear = self._shear + slip_increment / compliance.tangential
        pressure, shear, states = project(trial_pressure, trial_shear, self.faces.friction)
        return Tractions(
            trial_pressure,
            trial_shear,
            pressure,
            shear,
            states.astype(np.int8),
            self._over_tolerance(pressure - self._pressure, shear - self._shear),
        )

    def _over_tolerance(self, normal_forces: Array, tangential_forces: Array) -> float:
        """The largest of these differences of nodal forces, over what is tolerated."""
        tolerance = _TOLERANCE * float(np.abs(self._pressure).max())
        largest_force = float(np.abs(normal_forces).max())
        if self.faces.tangential:
            largest_shear = float(np.abs(tangential_forces).max())
            largest_force = max(largest_force, largest_shear / self.faces.shear_scale)
        return largest_force / tolerance if tolerance > 0 else np.inf

    def _newton_step(self, mapped_tractions: Tractions, change_of_loads: Array) -> None:
        """One Newton step: change the values of the nodes so that the linearised return mapping is
        met, and the loads have changed by `change_of_loads`.

        With p_m, q_m the mapped tractions and p_t, q_t the trial ones, a node has to meet

            open     p = p_m,                 q = q_m
            closed   gap = c_n (p_m - p_t)
            stick    slip increment = c_t (q_m - q_t)
            slip     q -+ f p = q_m -+ f p_m

        # notation: c_n, c_t compliances of the nodes (inverse penalties), f coefficient of friction
        """
        compliance = self.systems.layer
        states = mapped_tractions.states
        self._latest_states = states
        is_open = states == OPEN
        gap_under_pressure = compliance.normal * (
            mapped_tractions.pressure - mapped_tractions.trial_pressure
        )
        # One equation of each node in either direction: what its left side still has to change by.
        normal_changes = np.where(
            is_open, mapped_tractions.pressure - self._pressure, gap_under_pressure - self._gap
        )
        tangential_changes = np.zeros_like(normal_changes)
        signed_friction = slip_sign(states) * self.faces.friction
        if self.faces.tangential:
            slip_in_stick = self._slip_at_start + compliance.tangential * (
                mapped_tractions.shear - mapped_tractions.trial_shear
            )
            shear_beyond_cone = mapped_tractions.shear - signed_friction * mapped_tractions.pressure
            tangential_changes = np.where(
                states == STICK,
                slip_in_stick - self._slip,
                shear_beyond_cone - (self._shear - signed_friction * self._pressure),
            )
        *values_by_loads, values_by_changes = self.systems.corrections(
            states, len(change_of_loads), np.concatenate([normal_changes, tangential_changes])
        )
        self.newton_steps += 1
        self.values += values_by_changes
        moment = self.start.moment
        if moment is None:
            self.values += change_of_loads @ np.array(values_by_loads)
        else:
            self.values += change_of_loads[:-1] @ np.array(values_by_loads[:-1])
            self._turn(values_by_loads[-1], moment)
        # The equations are met to the last digit: the penalty would magnify their rounding.
        self._gap[~is_open] = gap_under_pressure[~is_open]
        self._pressure[is_open] = mapped_tractions.pressure[is_open]
        if self.faces.tangential:
            is_stuck = states == STICK
            self._slip[is_stuck] = slip_in_stick[is_stuck]
            self._shear[:] = np.where(
                is_stuck, self._shear, signed_friction * self._pressure + shear_beyond_cone
            )

    def _turn(self, values_by_tilt: Array, moment: float) -> None:
        """Turn the upper body until the nodal forces have the moment."""
        moment_by_tilt = self._moment(values_by_tilt)
        if not moment_by_tilt < -1e-12:
            raise SingularSet("one node alone holds no moment")
        self.values += (moment - self._moment(self.values)) / moment_by_tilt * values_by_tilt

    def _moment(self, values: Array) -> float:
        """Of the nodal forces in some values."""
        _, pressure, shear, _ = values[3:].reshape(4, -1)
        return -float(self.faces.interface.work_of_imposed(pressure, shear)[2])

    def _updated(self, multipliers: Array, mapped_tractions: Tractions) -> float:
        """Update the multipliers (2, n) of pressure and shear in place, to the tractions that the
        return mapping onto contact and Coulomb's cone gave; returns the largest change, over what
        is tolerated.

        The iterated values are gap − softness · pressure and slip + softness · shear, with the
        softness 1/stiffness of the penalty: they change with the multipliers.
        """
        pressure_change = mapped_tractions.pressure - multipliers[0]
        shear_change = mapped_tractions.shear - multipliers[1]
        self._gap -= self.softness.normal * pressure_change
        self._slip += self.softness.tangential * shear_change
        multipliers[0] = mapped_tractions.pressure
        multipliers[1] = mapped_tractions.shear
        return self._over_tolerance(pressure_change, shear_change)

    def answer(self) -> tuple[Array, States]:
        """Values (3 + 4 n,) and states (n,) of the contact after the loops have converged, with
        round-off removed: no gap of closed nodes, no force on open ones.

        A node within the tolerance of two states has the one that it had at the start of the
        increment. Its tractions are the same in both, but later events (a node opens or slips) are
        found by the state that it had.
        """
        compliance = self.systems.layer
        friction = self.faces.friction
        tolerance = _TOLERANCE * float(np.abs(self._pressure).max())
        was_open = self.start.states == OPEN
        mapped_tractions = self._mapped()
        is_touching = np.abs(self._pressure) <= tolerance
        is_touching &= np.abs(self._gap) <= tolerance * compliance.normal
        trial_pressure = np.where(
            is_touching,
            np.where(was_open, 0.0, _TOUCHING_PRESSURE),
            mapped_tractions.trial_pressure,
        )
        _, _, states = project(trial_pressure, mapped_tractions.trial_shear, friction)
        if self.faces.tangential:
            elastic_shear = mapped_tractions.trial_shear - self._shear
            shear_tolerance = tolerance * self.faces.shear_scale
            is_at_cone = np.abs(np.abs(self._shear) - friction * self._pressure) <= shear_tolerance
            is_at_cone &= np.abs(elastic_shear) <= shear_tolerance
            is_at_cone &= ~was_open & (states != OPEN)
            states = np.where(is_at_cone, self.start.states, states)
            is_stuck = states == STICK
            self._slip[is_stuck] = self._slip_at_start[is_stuck]
        is_open = states == OPEN
        is_met = np.abs(self._gap) <= tolerance * compliance.normal
        self._gap[~is_open & is_met] = 0.0
        self._pressure[is_open] = 0.0
        self._shear[is_open] = 0.0
        return self.values, states.astype(np.int8)
