r"""Return mapping of tractions: penalty method, and augmented Lagrangian of Simo and Laursen.

The faces carry trial tractions, projected onto p >= 0 and |q| <= f p,

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
with a softer penalty. Between faces with a layer the compliance of the penalty is added to that of
the layer, and the multipliers take its effect away again.

Source: Simo and Laursen (1992), Computers and Structures; see `law.project`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from halfplane_fe.interface import Interface
from halfplane_fe.law import project, slip_sign
from halfplane_fe.systems import LOADS_ARE_GIVEN, Actuators, Layer, SingularSet, Systems
from scenes import OPEN, STICK
from scenes.array_types import Array, Mask, States

# Tolerated change of a multiplier, and tolerated difference of projected and iterated tractions,
# over the largest nodal pressure.
_TOLERANCE = 1e-10
# Where Newton's method cycles, the penalty of the next try over that of the one before.
_PENALTY_RATIO = 0.1
_MOST_PENALTIES = 5
# Updates of the multipliers in an increment, at most: softer penalties take more of them.
_MOST_UPDATES = 2000
# Pressure of a node that touches without force, from which the sense of its slip is read.
_TOUCHING_PRESSURE = 1e-11


class Tractions(NamedTuple):
    """Nodal tractions before and after the return mapping of `law.project`; scaled.

    Attributes
    ----------
    trial_pressure, trial_shear
        (n,) before the return mapping
    pressure, shear, states
        (n,) after it: admissible tractions, and open, stick or slip
    error
        largest difference of the projected tractions from the iterated ones, over the tolerance
    """

    trial_pressure: Array
    trial_shear: Array
    pressure: Array
    shear: Array
    states: States
    error: float


class _TargetsOfStep(NamedTuple):
    """Right sides of the linearised equations of the return mapping in a Newton step: gap, slip and
    shear that the n nodes have to take; scaled.

    Attributes
    ----------
    gap
        (n,) of closed nodes
    slip_in_stick
        (n,) of sticking nodes
    limit_ratio
        (n,) q/p = +-f of sliding nodes; 0 of others
    shear_beyond_limit
        (n,) of open and sliding nodes: their q minus `limit_ratio` times p
    """

    gap: Array
    slip_in_stick: Array
    limit_ratio: Array
    shear_beyond_limit: Array


class Equilibrium(NamedTuple):
    """Values (3 + 4 n,) of the contact that meet the laws of contact and friction, states (n,) of
    its nodes, and the number of Newton steps taken.
    """

    values: Array
    states: States
    newton_steps: int


class Start(NamedTuple):
    """Start of an increment: values (3 + 4 n,) and node states (n,) there, the change (n_loads,) of
    the loads over the increment, and the moment at its end, where it is given; scaled.
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
    interface, friction, layer, has_shear, work_counts, actuators
        see `contact.ContactProblem`
    penalty
        (n,) normal and tangential e of the augmented Lagrangian; None for the penalty method,
        whose penalty is the stiffness of the layer
    shear_scale
        size of a nodal shear over that of a nodal pressure
    """

    interface: Interface
    friction: float
    layer: Layer
    has_shear: bool
    penalty: tuple[Array, Array] | None
    work_counts: Counter[str]
    shear_scale: float = 1.0
    actuators: Actuators = LOADS_ARE_GIVEN
    _systems: dict[int, Systems] = field(default_factory=dict, init=False)

    def equilibrium(self, start: Start, most_steps: int) -> Equilibrium | None:
        """Nodal values and states of the contact at the end of an increment, by return mapping.
        Penalties are tried from the stiffest one on; None where it converges with none of them.

        Parameters
        ----------
        start
            values and node states before the increment, and the change of its loads
        most_steps
            most Newton steps at constant multipliers

        Returns
        -------
        Equilibrium or None
            Values (3 + 4 n,): approach, U and tilt, then slip, pressure, shear and gap of the n
            nodes; states of the nodes; number of Newton steps at all penalties tried.
        """
        total_newton_steps = 0
        for penalty_number, penalty_compliance in enumerate(self._penalty_compliances()):
            # linear systems of the contact with this penalty, and the two loops of the increment
            systems = self._systems_at_penalty(penalty_number, penalty_compliance)
            iteration = _Iteration(self, systems, penalty_compliance, start)
            try:
                has_converged = iteration.run_to_convergence(most_steps)
            except SingularSet:
                has_converged = False
            total_newton_steps += iteration.newton_steps
            self.work_counts["Newton steps"] += iteration.newton_steps
            self.work_counts["multiplier updates"] += iteration.multiplier_updates
            if has_converged:
                values, node_states = iteration.values_and_states()
                return Equilibrium(values, node_states, total_newton_steps)
            self.work_counts["penalties softened"] += 1
        return None

    def _penalty_compliances(self) -> Iterator[Layer]:
        """Compliances of the nodes by the penalty, which are its inverse, (n,) normal and
        tangential [displacement / nodal force, scaled]; five of them, each softer than the one
        before.

        The first is that of the augmented Lagrangian's own penalty (`penalty`; None in the penalty
        method). In the penalty method the springs of the layer between the faces are the penalty:
        the first compliance added is zero. The others are 10, 100, ... times that of the augmented
        Lagrangian's penalty, or of the layer.
        """
        if self.penalty is None:
            yield Layer(
                np.zeros_like(self.layer.normal_compliance),
                np.zeros_like(self.layer.tangential_compliance),
            )
            least_compliance = self.layer
        else:
            normal_penalty, tangential_penalty = self.penalty
            least_compliance = Layer(1 / normal_penalty, 1 / tangential_penalty)
            yield least_compliance
        for penalty_number in range(1, _MOST_PENALTIES):
            # _PENALTY_RATIO: a tenth
            factor = _PENALTY_RATIO**-penalty_number
            yield Layer(
                least_compliance.normal_compliance * factor,
                least_compliance.tangential_compliance * factor,
            )

    def _systems_at_penalty(self, penalty_number: int, penalty_compliance: Layer) -> Systems:
        """The linear systems of the contact at one penalty: the faces have the compliance of the
        layer plus that of the penalty, each (n,) normal and tangential. Cached under the number of
        the penalty, 0 for the stiffest.
        """
        systems = self._systems.get(penalty_number)
        if systems is None:
            total_compliance = Layer(
                self.layer.normal_compliance + penalty_compliance.normal_compliance,
                self.layer.tangential_compliance + penalty_compliance.tangential_compliance,
            )
            systems = Systems(
                self.interface,
                total_compliance,
                self.friction,
                self.work_counts,
                self.has_shear,
                self.actuators,
            )
            self._systems[penalty_number] = systems
        return systems


@dataclass(eq=False)
class _Iteration:
    """Both loops of one increment at one penalty.

    Attributes
    ----------
    problem
        the bodies, friction and layer between the faces
    systems
        linear systems whose `layer` is the compliance of that layer and of the penalty together
    penalty_compliance
        inverse of the penalty, (n,) normal and tangential
    start
        of the increment, with the change of its loads
    values
        (3 + 4 n,) as iterated: approach, U and tilt, then slip, pressure, shear and gap of the n
        nodes, with G and S of the module in the place of gap and slip
    newton_steps, multiplier_updates
        numbers of them so far
    """

    problem: ReturnMapping
    systems: Systems
    penalty_compliance: Layer
    start: Start
    newton_steps: int = 0
    multiplier_updates: int = 0

    def __post_init__(self) -> None:
        self.values = self.start.values.copy()
        # (n,) views of `values`: what changes them changes `values`
        self._iterated_slip, self._iterated_pressure, self._iterated_shear, self._iterated_gap = (
            self.values[3:].reshape(4, -1)
        )
        self._slip_at_start = self._iterated_slip.copy()
        self._latest_states = self.start.states

    def run_to_convergence(self, most_steps: int) -> bool:
        """Run both loops of the augmented Lagrangian from the start of the increment, and return
        whether they converge. The result is left in `self.values`.

        The inner loop is Newton's method at constant multipliers, `most_steps` steps at most. The
        outer loop replaces the multipliers by the tractions found, until these change no more. The
        penalty method has no multipliers: one inner loop is all.

        - `start`: node states at the start of the increment, and the change of its loads.
        - `_iterated_pressure`, `_iterated_shear`: (n,) nodal forces, parts of `values`.
        - `penalty_compliance`: (n,) inverse of the penalty, normal and tangential.

        Raises
        ------
        SingularSet
            If so few nodes hold that the bodies are free to move.
        """
        # The first step adds the loads, with the node states at the start of the increment: trial
        # and projected tractions are both those at its start.
        pressure = self._iterated_pressure.copy()
        shear = self._iterated_shear.copy()
        tractions_at_start = Tractions(pressure, shear, pressure, shear, self.start.states, np.inf)
        self._newton_step(tractions_at_start, self.start.change_of_loads)

        # Outer loop. Projected tractions: trial tractions, projected onto p >= 0 and |q| <= f p.
        # Multipliers l of pressure and m of shear, (2, n): at first the tractions at the start.
        multipliers = np.stack([pressure, shear])
        has_multipliers = (
            self.penalty_compliance.normal_compliance.any()
            or self.penalty_compliance.tangential_compliance.any()
        )
        # _MOST_UPDATES: 2000
        while self.multiplier_updates < _MOST_UPDATES:
            projected_tractions = self._inner_loop(most_steps)
            if projected_tractions is None:
                return False
            if not has_multipliers:
                return True
            self.multiplier_updates += 1
            change_over_tolerance = self._update_multipliers(multipliers, projected_tractions)
            if change_over_tolerance <= 1.0 and self._projected_tractions().error <= 1.0:
                return True
        return False

    def _inner_loop(self, most_steps: int) -> Tractions | None:
        """Newton's method at constant multipliers: the projected tractions on which it converges,
        which are trial tractions, projected onto p >= 0 and |q| <= f p. None where a set of node
        states comes back (the steps would cycle), or after `most_steps`.

        `error` of projected tractions is their difference from the iterated ones, over the
        tolerance.
        """
        earlier_states: set[bytes] = set()  # sets of node states of all steps so far
        for _ in range(most_steps):
            projected_tractions = self._projected_tractions()
            if projected_tractions.error <= 1.0:
                return projected_tractions
            states_as_bytes = projected_tractions.states.tobytes()
            if states_as_bytes in earlier_states:
                return None
            earlier_states.add(states_as_bytes)
            # The loads do not change from step to step.
            projected_tractions = self._tractions_with_more_stick(projected_tractions)
            self._newton_step(projected_tractions, np.zeros_like(self.start.change_of_loads))
        return None

    def _tractions_with_more_stick(self, projected_tractions: Tractions) -> Tractions:
        """Projected tractions for the next Newton step, in which some nodes stick with their trial
        shear though they should slide by the return mapping. So the steps converge.

        - A node that slides one way and is to slide the other way sticks first: if it changed its
          direction at once, the next step would change it back.
        - Where all nodes are to slide, the one least beyond the Coulomb limit sticks: Q < f P, so
          one has to.

        `projected_tractions` has trial and projected pressure and shear of the n nodes, and their
        states: 0 open, 1 stick, above that slip. `_latest_states` (n,) are those of the step
        before.
        """
        is_sliding = projected_tractions.states > STICK
        is_sticking_first = (
            is_sliding
            & (self._latest_states > STICK)
            & (projected_tractions.states != self._latest_states)
        )

        # No stick is needed to balance Q on one half of a contact whose shear is odd in x, nor
        # where an actuator prescribes the tangential displacement.
        nothing_sticks = not np.any((projected_tractions.states == STICK) | is_sticking_first)
        may_slide_freely = (
            self.problem.interface.has_odd_shear or self.problem.actuators.prescribe_displacement
        )
        if self.problem.has_shear and nothing_sticks and not may_slide_freely:
            force_beyond_limit = (
                np.abs(projected_tractions.trial_shear)
                - self.problem.friction * projected_tractions.pressure
            )
            is_sticking_first[np.argmin(np.where(is_sliding, force_beyond_limit, np.inf))] = True
        return projected_tractions._replace(
            states=np.where(is_sticking_first, STICK, projected_tractions.states).astype(np.int8),
            shear=np.where(
                is_sticking_first, projected_tractions.trial_shear, projected_tractions.shear
            ),
        )

    def _projected_tractions(self) -> Tractions:
        """Tractions and states of the nodes by the return mapping, at the present values of the
        iteration. The trial tractions p - G/c_n and q + (S - S_start)/c_t are projected onto
        p >= 0 and |q| <= f p.

        The iterated gap G and slip S are those of penalty springs: with multipliers l of p and m of
        q, G = g + c (p - l) and S = s - c (q - m), c the compliance of the penalty.

        # notation: p, q iterated nodal pressure and shear; g, s gap and slip; S_start S at the
        # start of the increment; c_n, c_t compliances of the nodes, of layer and penalty together;
        # f coefficient of friction
        """
        compliance = self.systems.layer  # (n,) normal and tangential, of layer and penalty
        trial_pressure = self._iterated_pressure - self._iterated_gap / compliance.normal_compliance
        trial_shear = self._iterated_shear
        if self.problem.has_shear:
            slip_increment = self._iterated_slip - self._slip_at_start
            trial_shear = self._iterated_shear + slip_increment / compliance.tangential_compliance
        pressure, shear, node_states = project(trial_pressure, trial_shear, self.problem.friction)
        return Tractions(
            trial_pressure,
            trial_shear,
            pressure,
            shear,
            node_states.astype(np.int8),
            self._over_tolerance(pressure - self._iterated_pressure, shear - self._iterated_shear),
        )

    def _over_tolerance(self, pressure_changes: Array, shear_changes: Array) -> float:
        """Largest of some changes (n,) of nodal forces, over the tolerated one: 1e-10 of the
        largest nodal pressure; infinite where no node bears pressure.
        """
        tolerance = _TOLERANCE * float(np.abs(self._iterated_pressure).max())
        largest_change = float(np.abs(pressure_changes).max())
        if self.problem.has_shear:
            largest_shear_change = float(np.abs(shear_changes).max())
            largest_change = max(largest_change, largest_shear_change / self.problem.shear_scale)
        return largest_change / tolerance if tolerance > 0 else np.inf

    def _newton_step(self, projected_tractions: Tractions, change_of_loads: Array) -> None:
        """One Newton step: change `values` so that the linearised equations of the return mapping
        are met, with loads that differ by `change_of_loads` from those before the step.

        With p_m, q_m the projected tractions and p_t, q_t the trial ones, a node has to meet

            open     p = p_m,                 q = q_m
            closed   gap = c_n (p_m - p_t)
            stick    slip increment = c_t (q_m - q_t)
            slip     q -+ f p = q_m -+ f p_m

        # notation: gap, slip, p and q as iterated, parts of `values` (`_iterated_gap` and so on);
        # c_n, c_t compliances of the nodes, of layer and penalty together; f coefficient of
        # friction

        Parameters
        ----------
        projected_tractions
            trial and projected pressure and shear of the n nodes, and their states
        change_of_loads
            (n_loads,) of P, Q and, with bulk stress or tilt, both bulk stresses, tilt or moment
        """
        node_states = projected_tractions.states
        self._latest_states = node_states
        targets = self._targets_of_step(projected_tractions)
        # One equation of each node in either direction: right side minus present left side.
        normal_residuals = np.where(
            node_states == OPEN,
            projected_tractions.pressure - self._iterated_pressure,
            targets.gap - self._iterated_gap,
        )
        tangential_residuals = np.zeros_like(normal_residuals)
        if self.problem.has_shear:
            tangential_residuals = np.where(
                node_states == STICK,
                targets.slip_in_stick - self._iterated_slip,
                targets.shear_beyond_limit
                - (self._iterated_shear - targets.limit_ratio * self._iterated_pressure),
            )

        # Derivatives of the values by each load, (3 + 4 n,), and their change by the residuals.
        *derivatives_by_load, correction = self.systems.newton_correction(
            node_states,
            len(change_of_loads),
            np.concatenate([normal_residuals, tangential_residuals]),
        )
        self.newton_steps += 1
        self.values += correction
        # the moment at the end of the increment, the last load, if the tilt follows from it
        moment = self.start.moment
        if moment is None:
            self.values += change_of_loads @ np.array(derivatives_by_load)
        else:
            self.values += change_of_loads[:-1] @ np.array(derivatives_by_load[:-1])
            self._tilt_to_moment(derivatives_by_load[-1], moment)

        # Set once more without round-off error: the next trial tractions divide gap and slip by
        # small compliances.
        is_open = node_states == OPEN
        self._iterated_gap[~is_open] = targets.gap[~is_open]
        self._iterated_pressure[is_open] = projected_tractions.pressure[is_open]
        if self.problem.has_shear:
            is_stuck = node_states == STICK
            self._iterated_slip[is_stuck] = targets.slip_in_stick[is_stuck]
            self._iterated_shear[:] = np.where(
                is_stuck,
                self._iterated_shear,
                targets.limit_ratio * self._iterated_pressure + targets.shear_beyond_limit,
            )

    def _targets_of_step(self, projected_tractions: Tractions) -> _TargetsOfStep:
        """Right sides of the linearised equations of the return mapping in a Newton step, from
        projected tractions p_m, q_m and trial ones p_t, q_t of the n nodes:

            closed       gap = c_n (p_m - p_t)
            stick        slip = slip at the start of the increment + c_t (q_m - q_t)
            slip, open   q - r p = q_m - r p_m,  r = +-f in slip, else 0

        # notation: c_n, c_t compliances of the nodes, f coefficient of friction
        """
        compliance = self.systems.layer  # (n,) normal and tangential, of layer and penalty
        slip_sense = slip_sign(projected_tractions.states).astype(float)
        limit_ratio = slip_sense * self.problem.friction
        return _TargetsOfStep(
            gap=compliance.normal_compliance
            * (projected_tractions.pressure - projected_tractions.trial_pressure),
            slip_in_stick=self._slip_at_start
            + compliance.tangential_compliance
            * (projected_tractions.shear - projected_tractions.trial_shear),
            limit_ratio=limit_ratio,
            shear_beyond_limit=projected_tractions.shear
            - limit_ratio * projected_tractions.pressure,
        )

    def _tilt_to_moment(self, derivatives_by_tilt: Array, moment: float) -> None:
        """Tilt the upper body until the nodal forces have the given moment; scaled.

        `derivatives_by_tilt` (3 + 4 n,) are those of `values` at constant node states: approach, U
        and tilt, then slip, pressure, shear and gap of the nodes. SingularSet where a tilt does not
        change the moment.
        """
        moment_by_tilt = self._moment(derivatives_by_tilt)
        if not moment_by_tilt < -1e-12:
            raise SingularSet("one node alone holds no moment")
        tilt_change = (moment - self._moment(self.values)) / moment_by_tilt
        self.values += tilt_change * derivatives_by_tilt

    def _moment(self, values: Array) -> float:
        """Moment of the nodal forces among `values` (3 + 4 n,) of the contact, in the sense of the
        load M; scaled. Pressure and shear stand behind rigid motion (3) and slip (n).
        """
        _, pressure, shear, _ = values[3:].reshape(4, -1)
        return float(self.problem.interface.moment(pressure, shear))

    def _update_multipliers(self, multipliers: Array, projected_tractions: Tractions) -> float:
        """Replace the multipliers (2, n) of pressure and shear, in place, by the projected
        tractions; returns their largest change, over the tolerated one.

        Projected tractions are trial tractions, projected onto p >= 0 and |q| <= f p. With
        multipliers l of p and m of q, the iterated gap G = g + c_n (p - l) and slip
        S = s - c_t (q - m) change too (`_iterated_gap`, `_iterated_slip`).

        # notation: g gap, s slip, p and q iterated pressure and shear, c_n and c_t compliances of
        # the penalty, f coefficient of friction
        """
        pressure_change = projected_tractions.pressure - multipliers[0]
        shear_change = projected_tractions.shear - multipliers[1]
        self._iterated_gap -= self.penalty_compliance.normal_compliance * pressure_change
        self._iterated_slip += self.penalty_compliance.tangential_compliance * shear_change
        multipliers[0] = projected_tractions.pressure
        multipliers[1] = projected_tractions.shear
        return self._over_tolerance(pressure_change, shear_change)

    def values_and_states(self) -> tuple[Array, States]:
        """Values (3 + 4 n,) and node states (n,) at the end of the increment, after both loops have
        converged. Round-off errors are removed: closed nodes have no gap, open ones no force.

        The values are approach, U and tilt, then slip, pressure, shear and gap of the n nodes. A
        node within the tolerance of two states keeps the one that it had at the start of the
        increment: its tractions are the same in both, but later events (a node opens or slips) are
        found by the state that it had. The tolerance of a force is 1e-10 of the largest pressure.
        """
        # _TOLERANCE: 1e-10
        tolerance = _TOLERANCE * float(np.abs(self._iterated_pressure).max())
        node_states = self._states_within_tolerance(tolerance)
        if self.problem.has_shear:
            is_stuck = node_states == STICK
            self._iterated_slip[is_stuck] = self._slip_at_start[is_stuck]

        # Without round-off.
        is_open = node_states == OPEN
        self._iterated_gap[~is_open & self._has_no_gap(tolerance)] = 0.0
        self._iterated_pressure[is_open] = 0.0
        self._iterated_shear[is_open] = 0.0
        return self.values, node_states.astype(np.int8)

    def _has_no_gap(self, tolerance: float) -> Mask:
        """Whether the gap of each node is 0 within the tolerance, (n,): that of a force (scaled)
        times the compliance of the node.
        """
        # (n,) of layer and penalty
        normal_compliance = self.systems.layer.normal_compliance
        return np.abs(self._iterated_gap) <= tolerance * normal_compliance

    def _states_within_tolerance(self, tolerance: float) -> States:
        """States (n,) of the nodes by the return mapping of their trial tractions. A node that is
        between two states, but for the `tolerance` of a force (scaled), keeps the one that it had
        at the start of the increment.

        Between open and closed is a node with neither gap nor pressure, whose trial pressure is
        round-off. Between stick and slip is a node on the Coulomb limit without slip.
        """
        friction = self.problem.friction
        was_open = self.start.states == OPEN
        projected_tractions = self._projected_tractions()
        has_no_gap_or_pressure = np.abs(self._iterated_pressure) <= tolerance
        has_no_gap_or_pressure &= self._has_no_gap(tolerance)
        # Such a node is closed if it was. _TOUCHING_PRESSURE: positive, of the size of round-off
        adjusted_trial_pressure = np.where(
            has_no_gap_or_pressure,
            np.where(was_open, 0.0, _TOUCHING_PRESSURE),
            projected_tractions.trial_pressure,
        )
        _, _, node_states = project(
            adjusted_trial_pressure, projected_tractions.trial_shear, friction
        )
        if not self.problem.has_shear:
            return node_states
        shear_of_slip = (
            projected_tractions.trial_shear - self._iterated_shear
        )  # slip over compliance
        # `shear_scale`: size of a nodal shear over that of a nodal pressure, f of uncoupled bodies
        shear_tolerance = tolerance * self.problem.shear_scale
        shear_beyond_limit = np.abs(self._iterated_shear) - friction * self._iterated_pressure
        is_at_coulomb_limit = np.abs(shear_beyond_limit) <= shear_tolerance
        is_at_coulomb_limit &= np.abs(shear_of_slip) <= shear_tolerance
        is_at_coulomb_limit &= ~was_open & (node_states != OPEN)
        return np.where(is_at_coulomb_limit, self.start.states, node_states)
