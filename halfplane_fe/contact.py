"""Active set (semismooth Newton): contact and friction of two condensed bodies at one load, the law
met at every node.

All in scaled variables: lengths over the half-width, forces over the largest load P, displacements
over P/E*.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign, states_if_closed
from halfplane_fe.settings import Method
from halfplane_fe.systems import LOADS_ARE_GIVEN, Actuators, Layer, SingularSet, Systems
from halfplane_fe.tresca import pressure_at_known_shear, shear_at_known_pressure
from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    ConvergenceError,
    InputError,
    read_only_copy,
)
from scenes.array_types import Array, Indices, Mask, States

if TYPE_CHECKING:
    from halfplane_fe.return_mapping import ReturnMapping

# Rounding of nodal forces and displacements in scaled variables, both of order one: within it a
# node keeps its state.
ROUNDING = 1e-11
# Stiffness against tilt, scaled, that is rounding: of two nodes it is the square of their distance.
_LEAST_STIFFNESS = 1e-12
# Round-off of one node's force, against zero or the Coulomb limit: the force is a hundredth of the
# load or less, and the laws are met to 1e-9 of it.
_ROUNDING_OF_FORCE = 1e-13

# Force or gap that is the last digit of an answer, and not left by an event.
_RESIDUAL_ROUND_OFF = 1e-15
# Rates that are kept: of the sets that increments had, until their energies are found
# (`run._INCREMENTS_PER_BATCH`). In bytes, and so many sets at least.
_MOST_RATE_BYTES = 20_000_000
_FEWEST_CACHED_SETS = 128

_RIGID_NAMES = ("approach", "shift", "tilt")
_NODAL_NAMES = ("slip", "pressure", "shear", "gap")
# Places of the five loads: P, Q, the bulk stresses of both bodies, tilt or moment.
_BULK_STRESSES = slice(2, 4)
_TILT_OR_MOMENT = 4


def nodal_values(values: Array) -> Array:
    """Slip, pressure, shear and gap of n nodes, (4, ..., n), from the values (..., 3 + 4 n) of
    interface states: a view. Before these stand approach, tangential displacement and tilt.
    """
    if values.ndim == 1:
        return values[3:].reshape(4, -1)
    parts = values[..., 3:].reshape(*values.shape[:-1], 4, -1)
    axes_of_states = range(values.ndim - 1)
    return parts.transpose(values.ndim - 1, *axes_of_states, values.ndim)


def _motion_property(number: int) -> property:
    """Property of an interface state: approach (0), tangential displacement (1) or tilt (2) of the
    upper body, by its place among the values.
    """
    return property(lambda state: float(state.values[number]))


def _nodal_property(number: int) -> property:
    """Property of an interface state: slip (0), pressure (1), shear (2) or gap (3) of the n nodes,
    (n,), which stand behind three values of the rigid motion.
    """
    return property(lambda state: state.values[3:].reshape(-1, len(state.node_states))[number])


@dataclass(frozen=True, eq=False)
class InterfaceState:
    """The interface at one instant, with all that friction remembers. Scaled; arrays read-only.

    Attributes
    ----------
    time
        of the instant
    loads
        P and Q, or the movements of `actuators` in their place, or the five of `path` where it has
        bulk stress or tilt
    values
        (3 + 4 n,) approach, tangential displacement U (`shift`) and tilt of the upper body, then
        slip, pressure, shear and gap of the nodes. Gap and slip are those of the law: of the
        penalty method between the inner faces of its layer. Pressure and shear are nodal forces.
        The tilt is given or found from the moment. To save memory a long run drops all after the
        slip from some states (`run.PathRun`)
    node_states
        (n,) SurfaceState of each node
    resultants
        P and Q of the nodal forces where `loads` are movements; else None
    """

    time: float
    loads: tuple[float, ...]
    values: Array
    node_states: States
    resultants: tuple[float, float] | None = None

    approach, shift, tilt = (_motion_property(number) for number in range(3))
    slip, pressure, shear, gap = (_nodal_property(number) for number in range(4))

    @property
    def normal_load(self) -> float:
        """Normal load P: as given, or the resultant of the nodal forces where an actuator moves the
        body.
        """
        return self.loads[0] if self.resultants is None else self.resultants[0]

    @property
    def tangential_load(self) -> float:
        """Tangential load Q: as given, or the resultant of the nodal forces where an actuator moves
        the body.
        """
        return self.loads[1] if self.resultants is None else self.resultants[1]

    @property
    def is_complete(self) -> bool:
        """Whether the state still has nodal forces and gap, which long runs drop to save memory."""
        return len(self.values) > 3 + len(self.node_states)

    @property
    def is_closed(self) -> Mask:
        """Whether each node is in contact, (n,)."""
        return self.node_states != OPEN

    @property
    def stresses_and_tilt(self) -> Array:
        """Bulk stresses of the lower and upper body, and the tilt, (3,); zeros on a path without
        them.
        """
        if len(self.loads) == 2:
            return np.zeros(3)
        return np.array([*self.loads[_BULK_STRESSES], self.tilt])

    def changed(
        self, *, node_states: ArrayLike | None = None, **new_values: ArrayLike
    ) -> InterfaceState:
        """Copy of the state with other values, by name (`tilt`, `slip`, ...), or with other states
        of the nodes (open, stick, slip).
        """
        values = self.values.copy()
        for name, new_value in new_values.items():
            # _RIGID_NAMES: "approach", "shift", "tilt", the first three values
            if name in _RIGID_NAMES:
                values[_RIGID_NAMES.index(name)] = new_value
            else:
                # _NODAL_NAMES: "slip", "pressure", "shear", "gap"
                nodal_values(values)[_NODAL_NAMES.index(name)] = new_value
        changed_node_states = (
            self.node_states if node_states is None else read_only_copy(node_states, np.int8)
        )
        return replace(self, values=read_only_copy(values), node_states=changed_node_states)


class BesideTheFaces(InputError):
    """The line of action of the loads does not meet the part of the faces that may touch."""


class _ChangeByStates(NamedTuple):
    """Change of the contact's values by new node states, see `ContactProblem._change_by_states`.

    Attributes
    ----------
    start_state
        state of the contact before the increment
    new_node_states_bytes
        bytes of the states of the n nodes after the change: open, stick or slip
    change_of_values
        (3 + 4 n,) of approach, shift and tilt, then slip, p, q and gap of the nodes; the number 0
        where nothing changes
    """

    start_state: InterfaceState
    new_node_states_bytes: bytes
    change_of_values: Array | float


class _Outcome(NamedTuple):
    """How a method of solution of one increment ended.

    Attributes
    ----------
    state
        of the contact after the increment; None where the states of the nodes did not converge
    iterations
        number of iterations of the active set, or of turns between pressure and shear
    n_changing
        number of nodes that still changed their state at the end
    """

    state: InterfaceState | None
    iterations: int
    n_changing: int


class _PressureOfTurn(NamedTuple):
    """Pressure at known shear, as one turn between pressure and shear begins; n nodes, scaled.

    Attributes
    ----------
    normal_forces
        (n,) nodal normal forces
    approach
        normal approach of the upper body
    is_closed
        (n,) whether each node touches
    slip_offset
        (n,) slip by bulk stresses and tilt
    """

    normal_forces: Array
    approach: float
    is_closed: Mask
    slip_offset: Array


class _TrialStates(NamedTuple):
    """States that the laws of contact and friction give n nodes by trial forces. Scaled.

    Attributes
    ----------
    slip_increment
        (n,) slip in the increment
    friction_limit
        (n,) Coulomb limit: f times the trial pressure, or times 1e-11 where that is less
    if_closed
        (n,) stick, slip forward or reverse by the trial shear, as if the node were closed
    by_law
        (n,) the same; open where the trial pressure is not positive
    """

    slip_increment: Array
    friction_limit: Array
    if_closed: States
    by_law: States


@dataclass(eq=False)
class ContactProblem:
    """Contact problem of two bodies: all that does not change along a load path. Factorisations
    are cached, states of the contact are not.

    Attributes
    ----------
    interface
        compliance of the two bodies, scaled
    initial_gap
        (n,) initial gap h of the faces, scaled
    friction
        coefficient f
    layer
        compliance between the faces of the penalty method; zero for the exact law
    has_shear
        False where there can be no shear (no friction, or like bodies with no tangential load):
        that half is then skipped
    max_iterations
        of one increment
    trial_weights
        r_n, r_t of gap and slip in the trial tractions, one or (n,) each; they set the way to the
        answer, not the answer. In two dimensions a nodal force moves its node by O(1/E*) against
        its neighbours however fine the mesh, so 1 is natural. Of augmented_lagrangian they are the
        penalty
    has_given_moment
        whether the fifth load is the moment, so that the tilt follows from it, instead of the tilt
    work_counts
        counts of what was done
    method
        by which an equilibrium is found, see `settings.SolverSettings`
    actuators
        which loads are movements
    n_jumps
        increments in which the interface jumped from one solution to another, counted along the
        path by `stepping.increments_along`
    """

    interface: Interface
    initial_gap: Array
    friction: float
    layer: Layer
    has_shear: bool = True
    max_iterations: int = 100
    trial_weights: tuple[Array | float, Array | float] = (1.0, 1.0)
    has_given_moment: bool = False
    work_counts: Counter[str] = field(default_factory=Counter)
    method: Method = "active_set"
    actuators: Actuators = LOADS_ARE_GIVEN
    n_jumps: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        """Prepare caches and round-off limits of a contact problem.

        `interface.coupling` is the slip by normal forces, None where normal and tangential problem
        are uncoupled.
        """
        self._rates: dict[bytes, Array] = {}  # derivatives by the loads, by the node states
        # change of the values by new node states that was computed last
        self._latest_change: _ChangeByStates | None = None
        # Shear and slip of like bodies are in proportion to f, and their round-off with them.
        is_coupled = self.has_shear and self.interface.coupling is not None
        self._shear_scale = 1.0 if is_coupled else min(1.0, self.friction)
        # (2 n,) of gap or pressure, then of shear: 1e-15 in scaled variables
        self._residual_round_off = _RESIDUAL_ROUND_OFF * np.repeat(
            [1.0, self._shear_scale], len(self.initial_gap)
        )
        # q/p by the number of a state: 0, 0, +-f for slip in either sense
        all_states = np.array([OPEN, STICK, SLIP_FORWARD, SLIP_REVERSE], dtype=np.int8)
        self._shear_over_pressure_of_state = np.asarray(
            self.friction * slip_sign(all_states), dtype=float
        )

    @cached_property
    def _systems(self) -> Systems:
        """Linear systems of the contact for given states of its nodes (open, stick, slip), made
        when first used: faces that are solved on one half have a problem, and so systems, of their
        own.
        """
        return Systems(
            self.interface,
            self.layer,
            self.friction,
            self.work_counts,
            self.has_shear,
            self.actuators,
        )

    @cached_property
    def _return_mapping(self) -> ReturnMapping:
        """Solver by return mapping of trial tractions, made when it is first used.

        For the augmented Lagrangian it has a penalty on gap and slip at each of the n nodes, by the
        two `trial_weights`, forces over gap and slip. In the penalty method the layer of springs
        between the faces is the penalty.

        It takes the contact compliance (`interface`), friction, layer, counts of work and actuators
        of this contact problem, and the unit of shear forces by which round-off is judged
        (`_shear_scale`: f of uncoupled bodies).
        """
        from halfplane_fe.return_mapping import ReturnMapping  # noqa: PLC0415 - not by default

        penalty = None
        if self.method == "augmented_lagrangian":
            ones = np.ones_like(self.initial_gap)
            penalty = (self.trial_weights[0] * ones, self.trial_weights[1] * ones)
        return ReturnMapping(
            self.interface,
            self.friction,
            self.layer,
            self.has_shear,
            penalty,
            self.work_counts,
            self._shear_scale,
            self.actuators,
        )

    def unloaded_state(
        self, time: float = 0.0, loads: tuple[float, ...] = (0.0, 0.0), x_of_load: float = 0.0
    ) -> InterfaceState:
        """State of the contact before it carries any load: the faces just touch where the gap is
        least. Nodes that touch stick.

        Bulk stresses and tilt act already, and a tangential actuator is at its first position.
        Where the moment is given (`has_given_moment`), not the tilt, the faces touch on both sides
        of `x_of_load`. `actuators` states which of approach and tangential displacement (`shift`)
        are prescribed by an actuator in the place of P or Q.

        Parameters
        ----------
        time
            of the state
        loads
            P and Q, or the positions of actuators in their place; with bulk stress or tilt also the
            bulk stresses of lower and upper body, and tilt or moment. Scaled. In the state returned
            P and Q are 0, and a normal actuator is where the faces touch
        x_of_load
            x at which the resultant of the normal load first acts, scaled

        Raises
        ------
        BesideTheFaces
            Where the moment is given and no node lies on one side of `x_of_load`.
        """
        stresses_and_tilt = self._stresses_and_tilt_at_rest(loads, x_of_load)
        # Gap and slip (n,) by bulk stresses and tilt, then by the rigid motion (approach and shift)
        # of the upper body, such that the least gap is 0. `face_normals[1]`: y of the unit normals.
        gap_offset, slip_offset = self.gap_and_slip_by(stresses_and_tilt)
        gap_without_motion = self.initial_gap + gap_offset
        approach = float((gap_without_motion / self.interface.face_normals[1]).min())
        shift = loads[1] if self.actuators.prescribe_displacement else 0.0
        gap_by_approach, slip_by_approach = self.interface.gap_and_slip_by_motion(approach, shift)
        gap = gap_without_motion + gap_by_approach
        slip = slip_offset + slip_by_approach

        # Values: approach, shift and tilt, then slip, p, q (nodal forces) and gap of the nodes.
        no_force = np.zeros_like(self.initial_gap)
        rigid_motion = [approach, shift, stresses_and_tilt[2]]
        values = np.concatenate([rigid_motion, slip, no_force, no_force, gap])
        # ROUNDING: round-off of scaled forces and displacements, 1e-11
        node_states = np.where(gap <= ROUNDING, STICK, OPEN)
        load_or_position = approach if self.actuators.prescribe_approach else 0.0
        loads_at_rest = (load_or_position, shift, *loads[2:])
        return self._interface_state(time, loads_at_rest, read_only_copy(values), node_states)

    def _stresses_and_tilt_at_rest(self, loads: tuple[float, ...], x_of_load: float) -> Array:
        """Bulk stresses of the lower and upper body, and tilt of the upper one, (3,), before the
        contact carries any load: those of the loads, but where the moment is given the tilt at
        which the upper body rests without load. Zeros without bulk stress and tilt. Scaled.

        Parameters
        ----------
        loads
            P and Q, or the positions of actuators in their place; with bulk stress or tilt also
            both bulk stresses, and tilt or moment
        x_of_load
            x at which the resultant of the normal load first acts

        Raises
        ------
        BesideTheFaces
            Where the moment is given and no node lies on one side of `x_of_load`.
        """
        stresses_and_tilt = np.zeros(3)
        if len(loads) > 2:
            # _BULK_STRESSES: slice of both bulk stresses among the five loads; _TILT_OR_MOMENT:
            # index of the last
            stresses_and_tilt[:2] = loads[_BULK_STRESSES]
            stresses_and_tilt[2] = (
                self._resting_tilt(x_of_load) if self.has_given_moment else loads[_TILT_OR_MOMENT]
            )
        return stresses_and_tilt

    def _interface_state(
        self, time: float, loads: tuple[float, ...], values: Array, node_states: States
    ) -> InterfaceState:
        """State of the interface at an instant, with the resultants P and Q of its nodal forces
        where actuators move the bodies (None where P and Q are given).

        Parameters
        ----------
        time, loads
            instant, and P and Q or positions of actuators in their place, with bulk stress or tilt
            all five loads; scaled
        values
            (3 + 4 n,) approach, shift and tilt, then slip, pressure, shear and gap of the n nodes
        node_states
            (n,) open, stick or slip of the nodes
        """
        resultants = None
        if self.actuators.prescribe_movements:
            _, normal_forces, tangential_forces, _ = nodal_values(values)
            normal_load, tangential_load = self.interface.resultants(
                normal_forces, tangential_forces
            )
            resultants = (float(normal_load), float(tangential_load))
        return InterfaceState(time, loads, values, read_only_copy(node_states, np.int8), resultants)

    def equilibrium(
        self,
        start_state: InterfaceState,
        time: float,
        loads: tuple[float, ...],
        expected_node_states: States | None = None,
    ) -> tuple[InterfaceState, int]:
        """Equilibrium of the contact under new loads, one increment after a known state: every node
        is open, sticks, or slips by Coulomb's law.

        By default three methods are tried one after the other:

        - active set (semismooth Newton) from the expected states of the nodes;
        - active set from their states before the increment;
        - with shear or a given moment: pressure at known shear, then shear at known pressure, by
          turns.

        Where `method` is the penalty or the augmented Lagrangian, the return mapping alone is
        tried. It projects trial tractions onto p >= 0 and |q| <= f p.

        Parameters
        ----------
        start_state
            state of the contact before the increment
        time, loads
            at the end of the increment; P and Q (or movements of actuators), with bulk stress or
            tilt all five loads, scaled
        expected_node_states
            (n,) open, stick or slip of the nodes that are tried first; those of `start_state` by
            default

        Returns
        -------
        new_state, iterations
            State of the contact at the end of the increment, and the number of iterations: sets of
            node states and turns between pressure and shear, or Newton steps of the return mapping.

        Raises
        ------
        ConvergenceError
            With instant, loads and the number of nodes still changing.

        Examples
        --------
        >>> springs = np.eye(2)  # two nodes, each on a spring of its own
        >>> zeros = np.zeros(2)
        >>> places, normals = np.array([0.0, 1.0]), np.array([[0.0, 0.0], [1.0, 1.0]])
        >>> flat = Interface(places, np.ones(2), normals, zeros, springs, springs, None)
        >>> problem = ContactProblem(flat, np.array([0.0, 1.0]), 0.5, Layer(zeros, zeros))
        >>> pressed, _ = problem.equilibrium(problem.unloaded_state(), 1.0, (3.0, 0.0))
        >>> pressed.pressure.tolist()
        [2.0, 1.0]
        >>> sheared, _ = problem.equilibrium(pressed, 2.0, (3.0, 1.2))
        >>> (
        ...     sheared.shear.round(12).tolist(),
        ...     sheared.node_states.tolist(),
        ... )  # the second one slips at f p
        ([0.7, 0.5], [1, 2])
        """
        if self.method != "active_set":
            return self._equilibrium_by_return_mapping(start_state, time, loads)

        # Each attempt returns the new state (None where it fails), its number of iterations, and
        # the number of nodes that still changed their state at its end.
        new_state = None
        iterations = 0
        if expected_node_states is not None and not np.array_equal(
            expected_node_states, start_state.node_states
        ):
            new_state, iterations, n_changing = self._solve_by_active_set(
                start_state, time, loads, expected_node_states
            )
        if new_state is None:
            new_state, more_iterations, n_changing = self._solve_by_active_set(
                start_state, time, loads, start_state.node_states
            )
            iterations += more_iterations
        if new_state is None and (self.has_shear or self.has_given_moment):
            new_state, n_turns, n_changing = self._alternate_pressure_and_shear(
                start_state, time, loads
            )
            iterations += n_turns

        self.work_counts["contact iterations"] += iterations
        if new_state is None:
            raise ConvergenceError(
                f"contact: {n_changing} nodes still change state after {iterations} iterations at"
                f" time {time:.6g}, {self._loads_in_words(loads)}"
            )
        return new_state, iterations

    def _loads_in_words(self, loads: tuple[float, ...]) -> str:
        """Normal and tangential load with their names, for a message: "normal load 0.5, ...". Where
        an actuator prescribes a movement, that stands in the place of the load.
        """
        names = [
            "approach" if self.actuators.prescribe_approach else "normal load",
            "tangential displacement"
            if self.actuators.prescribe_displacement
            else "tangential load",
        ]
        values = ", ".join(f"{name} {load:.6g}" for name, load in zip(names, loads, strict=False))
        return f"{values} (over the largest normal load, or that over E*)"

    def _equilibrium_by_return_mapping(
        self, start_state: InterfaceState, time: float, loads: tuple[float, ...]
    ) -> tuple[InterfaceState, int]:
        """Equilibrium of the contact one increment after `start_state`, and its Newton steps, by
        return mapping: trial tractions are projected onto p >= 0 and |q| <= f p.

        It serves the penalty method and the augmented Lagrangian. `time` and `loads` (P and Q, or
        also both bulk stresses, and the tilt or the moment) are those at the end of the increment,
        scaled. `max_iterations` bounds the Newton steps.

        Raises
        ------
        ConvergenceError
            Where no penalty, however soft, lets it converge.
        """
        from halfplane_fe.return_mapping import Start  # noqa: PLC0415 - not by default

        moment = None  # the tilt is given, or there is none
        if self.has_given_moment and len(loads) > 2:
            # _TILT_OR_MOMENT: index of tilt or moment among the five loads
            moment = loads[_TILT_OR_MOMENT]
        change_of_loads = np.subtract(loads, start_state.loads)
        # values of the contact, states of the nodes, number of Newton steps; None without
        # convergence
        solution = self._return_mapping.equilibrium(
            Start(start_state.values, start_state.node_states, change_of_loads, moment),
            self.max_iterations,
        )
        if solution is None:
            raise ConvergenceError(
                f"contact: the return mapping does not converge, however soft the penalty, at time"
                f" {time:.6g}, {self._loads_in_words(loads)}"
            )
        self.work_counts["contact iterations"] += solution.newton_steps
        end_state = self._interface_state(
            time, loads, read_only_copy(solution.values), solution.states
        )
        return end_state, solution.newton_steps

    def state_following(
        self,
        start_state: InterfaceState,
        time: float,
        loads: tuple[float, ...],
        node_states: States,
    ) -> InterfaceState:
        """State of the contact one increment after `start_state`, for given states (n,) of its
        nodes: open, stick, slip forward or reverse. It is the linear step of the active-set method.

        Gap of closed nodes, force of open ones, slip increment of sticking ones, and |q| - f p of
        slipping ones are exactly zero. Whether the state obeys the laws of contact and friction is
        not checked here. `time` and `loads` (P and Q, or movements of actuators; with bulk stress
        or tilt all five) are those at the end of the increment, scaled.

        Raises
        ------
        SingularSet
            If so few nodes stick or touch that the bodies are free to move.
        """
        # (3 + 4 n,) approach, shift and tilt, then slip, p, q and gap of the nodes
        values = self.values_following(start_state, loads, node_states)
        # The solution of the linear system leaves round-off in these: set them exactly.
        slip, normal_forces, tangential_forces, gap = nodal_values(values)  # views
        is_stuck = (node_states == STICK) & self.has_shear
        is_open = node_states == OPEN
        np.copyto(slip, start_state.slip, where=is_stuck)
        np.copyto(normal_forces, 0.0, where=is_open)
        np.copyto(gap, 0.0, where=~is_open)
        np.copyto(
            tangential_forces,
            self._shear_over_pressure(node_states) * normal_forces,
            where=~is_stuck,
        )
        values.flags.writeable = False
        return self._interface_state(time, loads, values, node_states)

    def _shear_over_pressure(self, node_states: States) -> Array:
        """Shear over pressure q/p = +-f (n,) of the nodes that slip; 0 of the others."""
        shear_over_pressure: Array = self._shear_over_pressure_of_state.take(node_states)
        return shear_over_pressure

    def values_following(
        self, start_state: InterfaceState, loads: tuple[float, ...], node_states: States
    ) -> Array:
        """Approach, shift, tilt, then slip, p, q and gap of the n nodes, (3 + 4 n,), one increment
        after `start_state`, for given states (n,) of the nodes.

            values = start values + change by new node states + rates @ load increment

        The rates are derivatives by the loads at fixed node states. Gaps of closed nodes and forces
        of open ones are zero but for round-off. All is scaled. Where the moment is given
        (`has_given_moment`) it is the fifth load, and the tilt follows from it.

        Raises
        ------
        SingularSet
            If so few nodes stick or touch that the bodies are free to move.
        """
        change_by_states = self._change_by_states(start_state, node_states)  # at constant loads
        rates = self.rates(node_states, len(loads))  # (n_loads, 3 + 4 n)
        values: Array = (
            start_state.values + change_by_states + np.subtract(loads, start_state.loads) @ rates
        )
        # Nodes that change their state at constant tilt change the moment: a tilt restores it.
        if self.has_given_moment and len(loads) > 2:
            # _TILT_OR_MOMENT: index of tilt or moment among the five loads
            missing_moment = loads[_TILT_OR_MOMENT] - self._moments(values)
            values += missing_moment * rates[_TILT_OR_MOMENT]
        return values

    def rates(self, node_states: States, n_loads: int) -> Array:
        """Derivatives (n_loads, 3 + 4 n) of the contact's values by its loads while the n nodes
        keep their `node_states` (open, stick or slip). They are cached.

        The values are approach, shift and tilt, then slip, p, q and gap of the nodes. All is
        scaled.

        Raises
        ------
        SingularSet
            If so few nodes stick or touch that the bodies are free to move.
        """
        rates = self._rates.get(node_states.tobytes())  # from the cache
        if rates is None:
            # the linear system has the tilt as its fifth load; stored is that by the moment, if
            # the moment is given
            rates = self._store_rates(
                node_states, self._systems.value_derivatives(node_states, n_loads)
            )
        return rates

    def _store_rates(self, node_states: States, rates_by_load: Array) -> Array:
        """Derivatives (n_loads, 3 + 4 n) of the contact's values by its loads at fixed node states,
        stored in the cache of rates.

        The values v are approach, shift and tilt, then slip, p, q and gap of the n nodes. With the
        moment M given, derivatives at constant tilt t become those at constant M:

            dv/dF - dv/dt (dM/dF) / (dM/dt)   of the loads F = P, Q, bulk stresses
            dv/dt / (dM/dt)                   of the moment

        The cache holds 20 MB of such arrays, and 128 sets of node states at least.

        Parameters
        ----------
        node_states
            (n,) open, stick or slip of the nodes
        rates_by_load
            (n_loads, 3 + 4 n) derivatives by P, Q, bulk stresses and tilt

        Raises
        ------
        SingularSet
            If a tilt does not change the moment, so that none follows from it.
        """
        self.work_counts["rates"] += 1
        if self.has_given_moment and len(rates_by_load) > 2:
            # dM/dF and dM/dt; the latter is negative, and its least size 1e-12 is round-off
            *moments_by_load, moment_by_tilt = self._moments(rates_by_load)
            if not moment_by_tilt < -_LEAST_STIFFNESS:
                raise SingularSet("one node alone holds no moment")
            # The last factor turns the row of the tilt into that of the moment.
            load_factors = [*moments_by_load, moment_by_tilt - 1]
            # _TILT_OR_MOMENT: index of tilt or moment among the five loads
            rates_by_load = (
                rates_by_load
                - np.outer(load_factors, rates_by_load[_TILT_OR_MOMENT]) / moment_by_tilt
            )
        # The cache is bounded in bytes: the oldest set of node states leaves first.
        n_sets = len(self._rates)
        # _FEWEST_CACHED_SETS: 128; _MOST_RATE_BYTES: 20 MB
        if n_sets > _FEWEST_CACHED_SETS and n_sets * rates_by_load.nbytes > _MOST_RATE_BYTES:
            self._rates.pop(next(iter(self._rates)))
        return self._rates.setdefault(node_states.tobytes(), rates_by_load)

    def _change_by_states(self, start_state: InterfaceState, node_states: States) -> Array | float:
        """Change of the contact's values at constant loads, as the n nodes go from their states in
        `start_state` to new `node_states` (n,).

        The values (3 + 4 n,) are approach, shift and tilt, then slip, p, q and gap of the nodes.
        A node that opens loses its normal force; one that closes loses its gap; one that slips gets
        q = +-f p. The number 0 is returned where every node meets its new equations already. All is
        scaled.
        """
        # Increments from one start are tried with several loads: the latest change is cached.
        cached_change = self._latest_change
        node_states_bytes = node_states.tobytes()
        if (
            cached_change is not None
            and cached_change.start_state is start_state
            and cached_change.new_node_states_bytes == node_states_bytes
        ):
            return cached_change.change_of_values

        # What the new equations of the nodes miss in `start_state`: p or gap, and q - (+-f) p, if
        # that is more than round-off, 1e-15 in scaled variables.
        _, normal_forces, tangential_forces, gap = nodal_values(start_state.values)
        force_beyond_limit = (
            tangential_forces - self._shear_over_pressure(node_states) * normal_forces
        )
        residual = np.concatenate(
            [
                np.where(node_states == OPEN, normal_forces, gap),
                np.where(node_states == STICK, 0.0, force_beyond_limit),
            ]
        )
        # two equations of each node: n along the normal, then n along the tangent
        equation_numbers = (np.abs(residual) > self._residual_round_off).nonzero()[0]

        # Change of the values that removes it: the last row of the solutions. Those before are the
        # rates by each load, which the cache may lack.
        change_of_values: Array | float = 0.0
        if len(equation_numbers):
            rates_and_change = self._systems.value_derivatives(
                node_states, len(start_state.loads), equation_numbers, -residual[equation_numbers]
            )
            change_of_values = rates_and_change[-1]
            if node_states_bytes not in self._rates:
                self._store_rates(node_states, rates_and_change[:-1].copy())
        self._latest_change = _ChangeByStates(start_state, node_states_bytes, change_of_values)
        return change_of_values

    def _solve_by_active_set(
        self,
        start_state: InterfaceState,
        time: float,
        loads: tuple[float, ...],
        node_states: States,
    ) -> _Outcome:
        """One increment by the active-set method (semismooth Newton): solve for the values with
        given node states, let the laws choose new states, until these agree.

        It ends without a solution if the states of all nodes come back (a cycle), if the bodies are
        free to move, or at the largest number of iterations.

        Parameters
        ----------
        start_state
            state of the contact before the increment
        time, loads
            at the end of the increment, scaled
        node_states
            (n,) open, stick or slip of the nodes, to begin with

        Returns
        -------
        _Outcome
            State of the contact, None without a solution; number of iterations; number of nodes
            that still changed their state at the end.
        """
        node_states_chosen: set[bytes] = set()  # states of all nodes, as the law chose them so far
        n_changing = 0  # nodes to which the law gives another state
        try:
            for iteration in range(self.max_iterations + 1):
                solved_state = self.state_following(start_state, time, loads, node_states)
                next_node_states = self._states_by_law(solved_state, start_state)
                n_changing = int(np.count_nonzero(next_node_states != node_states))
                # counted: iterations in which other nodes slide than before the increment
                self.work_counts["slip iterations"] += iteration > 0 and not np.array_equal(
                    slip_sign(next_node_states), slip_sign(start_state.node_states)
                )
                if not n_changing:
                    return _Outcome(solved_state, max(iteration, 1), 0)
                if next_node_states.tobytes() in node_states_chosen:
                    return _Outcome(None, iteration, n_changing)
                if iteration:
                    node_states_chosen.add(next_node_states.tobytes())
                node_states = next_node_states
        except SingularSet:
            return _Outcome(None, max(len(node_states_chosen), 1), n_changing)
        return _Outcome(None, self.max_iterations, n_changing)

    def _alternate_pressure_and_shear(
        self, start_state: InterfaceState, time: float, loads: tuple[float, ...]
    ) -> _Outcome:
        """One increment from `start_state` to `time` and `loads`, by turns: pressure at known
        shear, then shear at known pressure. It serves where the active-set method returns to sets
        of node states that it had before.

        Both problems are convex, and coupling times friction is small, so that the turns converge.
        Each turn gives states of the nodes. As soon as the solution of all equations for these
        states obeys the laws of contact and friction, it is taken. Like materials need one turn.
        Where actuators prescribe movements, P and Q are those of the turn before.

        It returns the state of the contact (None without convergence), the number of turns, and the
        number of nodes that still changed their state. All is scaled.
        """
        self.work_counts["alternating solves"] += 1
        stresses_and_tilt = self._stresses_and_first_tilt(start_state, loads)
        shear = start_state.shear  # nodal forces, as the pressure is
        shift = start_state.shift  # tangential displacement of the upper body
        is_closed = start_state.is_closed
        # P and Q: given, or where actuators prescribe movements the resultants of the nodal forces
        resultants = start_state.resultants or loads[:2]
        n_changing = 0
        for turn_number in range(1, self.max_iterations + 1):
            # Pressure at known shear, then shear at known pressure.
            gap_without_pressure = self._gap_without_pressure(shear, shift)
            if self.has_given_moment:
                stresses_and_tilt[2] = self._tilt_at_known_shear(
                    gap_without_pressure, shear, is_closed, stresses_and_tilt, loads
                )
            pressure_of_turn = self._pressure_of_turn(
                gap_without_pressure, shear, is_closed, stresses_and_tilt, resultants[0]
            )
            is_closed = pressure_of_turn.is_closed
            node_states = np.where(is_closed, STICK, OPEN).astype(np.int8)
            if self.has_shear:
                shear, shift, node_states = self._shear_of_turn(
                    start_state.slip, pressure_of_turn, resultants[1]
                )

            # All equations for these node states, and the states that the laws then give. Without
            # a sticking node this system is singular, unless an actuator holds the upper body.
            if not np.any(node_states == STICK) and not self.actuators.prescribe_displacement:
                continue
            solved_state = self.state_following(start_state, time, loads, node_states)
            resultants = solved_state.resultants or resultants
            n_changing = int(
                np.count_nonzero(self._states_by_law(solved_state, start_state) != node_states)
            )
            if not n_changing:
                return _Outcome(solved_state, turn_number, 0)
        return _Outcome(None, self.max_iterations, n_changing)

    def _stresses_and_first_tilt(
        self, start_state: InterfaceState, loads: tuple[float, ...]
    ) -> Array:
        """Bulk stresses of the lower and the upper body under new loads, and the tilt, (3,),
        scaled. Where the moment is given, not the tilt, that of `start_state` is a first estimate.

        `loads` are P and Q, with bulk stress or tilt also the bulk stresses, and tilt or moment;
        without these all three are 0.
        """
        # A contact state takes its bulk stresses from its loads, its tilt from its values.
        stresses_and_tilt = replace(start_state, loads=loads).stresses_and_tilt
        if len(loads) > 2 and not self.has_given_moment:
            # _TILT_OR_MOMENT: index of tilt or moment among the five loads
            stresses_and_tilt[2] = loads[_TILT_OR_MOMENT]
        return stresses_and_tilt

    def _gap_without_pressure(self, shear: Array, shift: float) -> Array:
        """Initial gap of the n nodes plus what known nodal shear (n,) and tangential displacement
        of the upper body (`shift`) add to it, (n,); scaled.

        By reciprocity the gap by shear is minus the transposed slip by pressure. On curved faces,
        whose unit normals have an x component, `shift` changes the gap.
        """
        minus_gap_by_shear = self._slip_by_normal_forces.T @ shear
        normals_x = self.interface.face_normals[0]
        return np.asarray(self.initial_gap - minus_gap_by_shear + normals_x * shift)

    @cached_property
    def _slip_by_normal_forces(self) -> Array:
        """Slip of each node by a unit normal force on each, (n, n), scaled: the coupling of unlike
        bodies; zeros of like ones.
        """
        if self.interface.coupling is None:
            return np.zeros_like(self.interface.normal_compliance)
        return self.interface.coupling

    def _pressure_of_turn(
        self,
        gap_without_pressure: Array,
        shear: Array,
        is_closed: Mask,
        stresses_and_tilt: Array,
        normal_load: float,
    ) -> _PressureOfTurn:
        """Contact without friction at known shear: pressure, approach and closed nodes. Scaled.

        Parameters
        ----------
        gap_without_pressure
            (n,) initial gap plus what the known shear and the tangential displacement add to it
        shear
            (n,) known nodal forces along the tangent
        is_closed
            (n,) nodes that are assumed to touch first
        stresses_and_tilt
            (3,) bulk stresses of the lower and upper body, and tilt
        normal_load
            P; the pressure carries what of it the shear does not carry on curved faces
        """
        normals_x = self.interface.face_normals[0]  # (n,) x of the unit normal at each node
        gap_offset, slip_offset = self.gap_and_slip_by(stresses_and_tilt)
        # ROUNDING: round-off of scaled forces and displacements, 1e-11
        normal_forces, approach, is_closed = pressure_at_known_shear(
            self._systems,
            gap_without_pressure + gap_offset,
            normal_load - float(normals_x @ shear),
            is_closed,
            ROUNDING,
        )
        return _PressureOfTurn(normal_forces, approach, is_closed, slip_offset)

    def _shear_of_turn(
        self, start_slip: Array, pressure_of_turn: _PressureOfTurn, tangential_load: float
    ) -> tuple[Array, float, States]:
        """Friction problem at known pressure: shear (n,), tangential displacement of the upper
        body, and states (n,) of the nodes. Scaled.

        Parameters
        ----------
        start_slip
            (n,) slip before the increment
        pressure_of_turn
            pressure and approach of this turn; tension counts as 0 for the Coulomb limit
        tangential_load
            Q; without effect on one half of a contact whose shear is odd in x
        """
        normals_x = self.interface.face_normals[0]  # (n,) x of the unit normal at each node
        normal_forces = pressure_of_turn.normal_forces
        # slip before the increment, minus that at its end that does not come from shear and `shift`
        slip_deficit = (
            start_slip
            - pressure_of_turn.slip_offset
            - self._slip_by_normal_forces @ normal_forces
            - normals_x * pressure_of_turn.approach
        )
        load_of_shear = (
            None
            if self.interface.has_odd_shear
            else tangential_load + float(normals_x @ normal_forces)
        )
        # ROUNDING: round-off of scaled forces and displacements, 1e-11
        return shear_at_known_pressure(
            self._systems, np.maximum(normal_forces, 0.0), slip_deficit, load_of_shear, ROUNDING
        )

    def _states_by_law(self, solved_state: InterfaceState, start_state: InterfaceState) -> States:
        """States (n,) that the laws of contact and friction give the nodes by trial forces: open,
        stick, slip forward or reverse.

        With gap g and increment s of the slip since `start_state`, the trial pressure is p - r_n g,
        the trial shear q + r_t s. A node is closed if its trial pressure is positive, and slips if
        its trial shear is beyond f times that pressure. Within round-off of either limit a node
        keeps the state it has: 1e-11 of a displacement, 1e-13 of a force, scaled. A node that slid
        one way and is to slide the other way sticks first.

        # notation: r_n, r_t weights of gap and slip, f coefficient of friction

        Parameters
        ----------
        solved_state
            solution of an increment for the node states in it
        start_state
            state of the contact before the increment
        """
        node_states = solved_state.node_states
        trial_states = self._trial_states(solved_state, start_state)
        changing_nodes = (trial_states.by_law != node_states).nonzero()[0]
        if not len(changing_nodes):
            return node_states
        next_states = node_states.copy()
        next_states[changing_nodes] = self._states_beyond_round_off(
            solved_state, trial_states, changing_nodes
        )
        return next_states

    def _trial_states(
        self, solved_state: InterfaceState, start_state: InterfaceState
    ) -> _TrialStates:
        """States that the laws give the nodes by the trial pressure p - r_n g and the trial shear
        q + r_t s, whatever their round-off; with the slip increment s and the Coulomb limit.

        # notation: p, q nodal forces of pressure and shear, g gap; r_n, r_t weights of gap and slip
        # (`trial_weights`)

        Parameters
        ----------
        solved_state
            solution of an increment; what its equations set to zero is exactly zero: weighted, its
            round-off would look like a force
        start_state
            state of the contact before the increment
        """
        slip, normal_forces, tangential_forces, gap = nodal_values(solved_state.values)
        slip_increment = slip - start_state.slip
        r_normal, r_tangential = self.trial_weights  # weights of gap and slip
        trial_normal_forces = normal_forces - r_normal * gap
        # ROUNDING: round-off of scaled forces and displacements, 1e-11
        friction_limit = self.friction * np.maximum(trial_normal_forces, ROUNDING)
        states_of_closed_nodes = np.full_like(solved_state.node_states, STICK)
        if self.has_shear:
            states_of_closed_nodes = states_if_closed(
                tangential_forces + r_tangential * slip_increment, friction_limit
            )
        return _TrialStates(
            slip_increment,
            friction_limit,
            states_of_closed_nodes,
            np.where(trial_normal_forces > 0, states_of_closed_nodes, OPEN),
        )

    def _states_beyond_round_off(
        self, solved_state: InterfaceState, trial_states: _TrialStates, changing_nodes: Indices
    ) -> States:
        """New states (m,) of the nodes that are to change theirs by the trial forces. Within
        round-off of touching or of the Coulomb limit a node keeps the state it has.

        A sliding node that turns round sticks first: going straight from forward to reverse slip,
        the iteration would cycle between sets of states.

        Parameters
        ----------
        solved_state
            solution of an increment, with the states of its nodes
        trial_states
            states of all nodes by trial forces (`by_law`), and the same as if each node were closed
            (`if_closed`); slip increments and Coulomb limits
        changing_nodes
            (m,) numbers of the nodes whose state changes
        """
        _, normal_forces, tangential_forces, gap = nodal_values(solved_state.values)
        present_states = solved_state.node_states[changing_nodes]
        was_closed = present_states != OPEN
        # `_shear_scale` is the unit of tangential force and slip: f of uncoupled bodies, else 1.
        # _ROUNDING_OF_FORCE: 1e-13; ROUNDING: 1e-11, of displacements
        has_no_normal_force = np.abs(normal_forces[changing_nodes]) <= _ROUNDING_OF_FORCE
        just_touches = has_no_normal_force & (np.abs(gap[changing_nodes]) <= ROUNDING)
        force_beyond_limit = (
            np.abs(tangential_forces[changing_nodes]) - trial_states.friction_limit[changing_nodes]
        )
        has_not_moved = (
            np.abs(trial_states.slip_increment[changing_nodes]) <= ROUNDING * self._shear_scale
        )
        is_at_limit = np.abs(force_beyond_limit) <= _ROUNDING_OF_FORCE * self._shear_scale
        keeps_state = was_closed & is_at_limit & has_not_moved
        is_closed = np.where(just_touches, was_closed, trial_states.by_law[changing_nodes] != OPEN)
        states_of_closed_nodes = np.where(
            keeps_state, present_states, trial_states.if_closed[changing_nodes]
        )
        new_states = np.where(is_closed, states_of_closed_nodes, OPEN)
        has_turned = (
            (new_states != present_states) & (new_states > STICK) & (present_states > STICK)
        )
        return np.where(has_turned, STICK, new_states)

    def _tilt_at_known_shear(
        self,
        gap_without_pressure: Array,
        shear: Array,
        is_closed: Mask,
        stresses_and_tilt: Array,
        loads: tuple[float, ...],
    ) -> float:
        """Tilt of the upper body at which pressure and known shear have the given moment, scaled.

        The larger the tilt, the smaller the moment: found by bracketing and Brent's method.

        Parameters
        ----------
        gap_without_pressure
            (n,) initial gap plus what the known shear and the tangential displacement add to it
        shear
            (n,) known nodal forces along the tangent
        is_closed
            (n,) nodes that are assumed to touch first
        stresses_and_tilt
            (3,) bulk stresses of the lower and upper body, and the tilt at which the search begins
        loads
            P, Q, both bulk stresses and the moment, scaled

        Raises
        ------
        ConvergenceError
            Where no tilt has the moment.
        """
        # P minus the part of it that the shear carries on curved faces
        load_of_pressure = loads[0] - float(self.interface.face_normals[0] @ shear)
        # _TILT_OR_MOMENT: index of tilt or moment among the five loads
        moment = loads[_TILT_OR_MOMENT]

        def excess_moment(tilt: float) -> float:
            """Moment of pressure and known shear at a tilt, minus the given `moment`. It is minus
            their work per unit of tilt. The pressure is that of a contact without friction under
            `load_of_pressure`, with `gap_without_pressure` and the gap by bulk stress and tilt.
            """
            gap_offset, _ = self.gap_and_slip_by(np.array([*stresses_and_tilt[:2], tilt]))
            # ROUNDING: round-off of scaled forces and displacements, 1e-11
            normal_forces, _, _ = pressure_at_known_shear(
                self._systems,
                gap_without_pressure + gap_offset,
                load_of_pressure,
                is_closed,
                ROUNDING,
            )
            return -float(self.interface.work_per_stress_and_tilt(normal_forces, shear)[2]) - moment

        initial_tilt = float(stresses_and_tilt[2])
        slope_of_gap = float(np.ptp(self.initial_gap)) / float(np.ptp(self.interface.x))
        # The range is a thousandth of the gap's slope at first, doubled until it holds the tilt.
        for half_range in slope_of_gap * 2.0 ** np.arange(-10, 30):
            lower_bound = initial_tilt - half_range
            upper_bound = initial_tilt + half_range
            if excess_moment(lower_bound) >= 0 >= excess_moment(upper_bound):
                return float(
                    scipy.optimize.brentq(
                        excess_moment,
                        lower_bound,
                        upper_bound,
                        xtol=1e-15 * half_range,
                        rtol=8.9e-16,
                    )
                )
        raise ConvergenceError(
            f"contact: no tilt has the moment {moment:.6g} (scaled): its line of action misses"
            " the faces"
        )

    def _resting_tilt(self, x_of_load: float) -> float:
        """Tilt at which the upper body, pressed at `x_of_load`, rests on the lower one without
        load: the faces touch on both sides of that place. All is scaled.

        It is minus the slope of the lower convex hull of the initial gap there. Of all chords
        between a node before that place and one beyond it, the hull follows the one that is lowest
        there.

        Raises
        ------
        BesideTheFaces
            Where no node lies on one side of that place.
        """
        n_y = self.interface.face_normals[1]  # y of the unit normal at each node
        # of the loads (bulk stress of lower and upper body, tilt) the tilt alone
        gap_by_unit_tilt, _ = self.gap_and_slip_by(np.array([0.0, 0.0, 1.0]))
        lever_arms = gap_by_unit_tilt / n_y  # (n,) x of the nodes: gap along y by a unit tilt
        gap_along_y = self.initial_gap / n_y
        if not lever_arms[0] < x_of_load < lever_arms[-1]:
            raise BesideTheFaces(
                "load: the upper body falls over: its line of action meets the faces beside where"
                " they can touch; take a smaller moment, or wider bodies"
            )
        nodes_before = np.flatnonzero(lever_arms <= x_of_load)
        nodes_beyond = np.flatnonzero(lever_arms > x_of_load)
        gap_rises = np.subtract.outer(gap_along_y[nodes_beyond], gap_along_y[nodes_before])
        chord_slopes = gap_rises / np.subtract.outer(
            lever_arms[nodes_beyond], lever_arms[nodes_before]
        )
        # The gap at that place on the chord of each pair of nodes; the lowest chord is the hull's.
        gaps_of_chords = gap_along_y[nodes_before] + chord_slopes * (
            x_of_load - lever_arms[nodes_before]
        )
        return -float(chord_slopes.flat[np.argmin(gaps_of_chords)])

    def gap_and_slip_by(self, stresses_and_tilt: Array) -> tuple[Array, Array]:
        """Gap and slip that bulk stresses of the lower and upper body, and tilt, (..., 3), add at
        the n nodes, each (..., n); where all of these are 0, or cannot act, each is (n,) zeros.

        `gap_and_slip_per_stress_and_tilt` (2, n, 3) are both by a unit of each.
        """
        if self.interface.gap_and_slip_per_stress_and_tilt is None or not stresses_and_tilt.any():
            return np.zeros_like(self.initial_gap), np.zeros_like(self.initial_gap)
        added_gap, added_slip = np.moveaxis(
            np.tensordot(
                stresses_and_tilt, self.interface.gap_and_slip_per_stress_and_tilt, (-1, -1)
            ),
            -2,
            0,
        )
        return added_gap, added_slip

    def _moments(self, values: Array) -> Array:
        """Moment (...) of the nodal forces about x = 0, in values (..., 3 + 4 n) of interface
        states; scaled.
        """
        _, pressure, shear, _ = nodal_values(values)
        return np.asarray(-self.interface.work_per_stress_and_tilt(pressure, shear)[..., 2])
