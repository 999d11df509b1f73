"""Energy balance and Coulomb certificates of increments: checks that need no reference. Scaled,
like `contact`.

With loads, forces and displacements taken at the middle of the increment the balance

    P d(delta) + Q dU + sum F_i de_i = d(elastic energy) + sum q ds - sum p dg,   F = S q - G p

is an identity of the discrete problem: a check of the algebra. Here e are the bulk stresses and the
tilt, and F de is -m_q d(eps) - M d(alpha) of half-planes, see `interface`. What the increment
itself costs shows in the three ways to write the friction work: at its middle (f p ds), trapezoidal
(q ds), at its end (first order). The work of the loads at its end, P d(delta) + Q dU with the new P
and Q, has the normal part of that error in it. On the interface there is none, because increments
land on each touch and release, so that p dg is zero in each.

The loads follow a curve where the increment solves its chord. While the states of the nodes stay, p
and s are linear in P, Q and the other loads, and the friction work along the curve is that along
the chord plus, node by node and for each pair of loads,

    f (p_Q s_P - p_P s_Q) (int Q dP of the curve - of the chord),

subscripts being derivatives by the loads. The sum over the nodes is the work of the loads, (U_P -
delta_Q) times that area.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState, nodal_values
from halfplane_fe.interface import Interface
from halfplane_fe.law import force_to_limit, is_slip_onset, slip_sign, step_errors, violations
from scenes import STICK
from scenes.array_types import Array, Indices, Mask, States


@dataclass(frozen=True, eq=False)
class Energies:
    """Energies of m increments (over P^2/E*), each (m,), and the dissipation of their nodes (m, n).

    Most names are also keys of a solution's record.

    Attributes
    ----------
    dissipation
        friction work f p |ds| of each sliding node, p being the mean of the increment, or of its
        parts before and after nodes start to slide; with what the curvature of the load path adds
    loop_work
        integral of Q dU along the load path, and of q in the slip by bulk stress (-m_q d(eps) of
        half-planes)
    external
        work of P, Q, bulk stresses and tilt along the chord of the load path
    external_end_of_step
        work of P, Q, bulk stresses and tilt with the loads at the end of the increment
    curve
        what the curvature of the load path adds to `external`, all of it friction work
    elastic
        change of elastic energy, that of the penalty layer included
    layer
        change of the energy of the penalty layer alone: part of `elastic`, not beside it
    interface
        trapezoidal work of shear minus that of pressure
    end_of_step
        work of shear minus that of pressure, with the forces at the end of the increment
    step_error
        bound of the error of the dissipation, see `law.step_errors`
    kink_work
        part of the dissipation, where three nodes and more start to slide, by kinks of pressure
        and slip, see `_work_with_onsets`; its error is smaller than it
    """

    dissipation: Array
    loop_work: Array
    external: Array
    external_end_of_step: Array
    curve: Array
    elastic: Array
    layer: Array
    interface: Array
    end_of_step: Array
    step_error: Array
    kink_work: Array


class _Increments(NamedTuple):
    """m increments, each between two contact states; n nodes. Scaled.

    Attributes
    ----------
    p_at_start, p_at_end, q_at_start, q_at_end
        (m, n) nodal forces, of pressure p and of shear q
    slip_change, gap_change
        (m, n) changes of the slip of the upper face over the lower, and of the gap
    node_states_before, node_states_after
        (m, n) open, stick or slip of the nodes before the increment, and during it
    load_changes
        (m, k) changes of the k loads, or of the movements in their place
    """

    p_at_start: Array
    p_at_end: Array
    q_at_start: Array
    q_at_end: Array
    slip_change: Array
    gap_change: Array
    node_states_before: States
    node_states_after: States
    load_changes: Array

    @classmethod
    def between(
        cls,
        contact_states: Sequence[InterfaceState],
        solved_node_states: States,
        friction: float,
    ) -> _Increments:
        """The m increments between m + 1 contact states that follow each other: forces, slips,
        node states and changes of the loads.

        `solved_node_states` (m, n) are open, stick or slip of the nodes as each increment was
        solved: before a node that touches or lets go at its very end changes. Nodes that were to
        start to slide, but have not moved, keep the state from before. `friction` is the
        coefficient f.
        """
        slip, p, q, gap = nodal_values(np.stack([state.values for state in contact_states]))
        slip_change = np.diff(slip, axis=0)
        node_states_before = np.stack([state.node_states for state in contact_states[:-1]])
        return cls(
            p_at_start=p[:-1],
            p_at_end=p[1:],
            q_at_start=q[:-1],
            q_at_end=q[1:],
            slip_change=slip_change,
            gap_change=np.diff(gap, axis=0),
            node_states_before=node_states_before,
            node_states_after=_without_idle_onsets(
                friction, node_states_before, solved_node_states, slip_change
            ),
            load_changes=np.diff([state.loads for state in contact_states], axis=0),
        )

    def subset(self, numbers: Indices) -> _Increments:
        """Those increments of the m that have these numbers: all arrays at these rows."""
        return _Increments._make(values[numbers] for values in self)

    def interface_work(self, p: Array, q: Array) -> Array:
        """Work (m,) of nodal shear q in the slip of each increment, minus that of nodal pressure p
        in the change of the gap; p and q are (m, n), over P^2/E*.
        """
        return np.asarray((q * self.slip_change - p * self.gap_change).sum(axis=1))


class _Movements(NamedTuple):
    """Loads of m increments, and the changes of the displacements in which they do work. Scaled.

    The mean load of an increment times the change of displacement is its work along the chord of
    the load path, exactly.

    Attributes
    ----------
    mean_loads, loads_at_end
        (m, 2) normal load P and tangential load Q: their means over each increment, and at its end
    approach_change, shift_change
        (m,) changes of the approach of the upper body, and of its tangential displacement U
    stress_and_tilt_change
        (m, 3) changes of the bulk stresses of the lower and the upper body, and of the tilt
    """

    mean_loads: Array
    loads_at_end: Array
    approach_change: Array
    shift_change: Array
    stress_and_tilt_change: Array

    @classmethod
    def between(cls, contact_states: Sequence[InterfaceState]) -> _Movements:
        """Loads and movements of the m increments between m + 1 contact states that follow each
        other.
        """
        loads = np.array([(state.normal_load, state.tangential_load) for state in contact_states])
        # the first two values of a contact state are the approach and U
        rigid_motion = np.array([state.values[:2] for state in contact_states])
        approach_change, shift_change = np.diff(rigid_motion, axis=0).T
        return cls(
            mean_loads=(loads[:-1] + loads[1:]) / 2,
            loads_at_end=loads[1:],
            approach_change=approach_change,
            shift_change=shift_change,
            stress_and_tilt_change=np.diff(
                [state.stresses_and_tilt for state in contact_states], axis=0
            ),
        )

    def work_of_loads(self, interface: Interface, loads: Array, p: Array, q: Array) -> Array:
        """Work (m,) of loads P and Q (m, 2), of bulk stresses and of tilt in these movements, over
        P^2/E*.

        That of bulk stresses and tilt is the work of the nodal forces p and q (m, n) in the gap and
        slip that a unit of each causes; `interface` has these.
        """
        work_per_unit = interface.work_per_stress_and_tilt(p, q)
        return np.asarray(
            loads[:, 0] * self.approach_change
            + loads[:, 1] * self.shift_change
            + (work_per_unit * self.stress_and_tilt_change).sum(axis=1)
        )


def elastic_energies(
    problem: ContactProblem, contact_states: Sequence[InterfaceState]
) -> tuple[Array, Array]:
    """Elastic energy of both bodies and of the penalty layer between them, and that of the layer
    alone, at m contact states, (m,) each, over P^2/E*.

    The first is (p^T N p - 2 q^T K p + q^T T q)/2. N p - K^T q is the gap by the nodal forces,
    T q - K p minus the slip by them. Both are what is left of gap and slip without the initial gap,
    the rigid motion of the upper body, bulk stresses and tilt.

    # notation: p, q nodal forces, pressure and shear; N normal, T tangential compliance of bodies
    # and layer together, K coupling (slip by pressure)

    Parameters
    ----------
    problem
        the contact problem: contact compliance, initial gap, and compliances (n,) of its layer
    contact_states
        each with its values: approach and tangential displacement, then slip, pressure, shear and
        gap of the nodes; and with bulk stresses and tilt
    """
    values = np.stack([state.values for state in contact_states])
    slip, pressure, shear, gap = nodal_values(values)
    gap_by_motion, slip_by_motion = problem.interface.gap_and_slip_by_motion(
        values[:, 0, None], values[:, 1, None]
    )
    stresses_and_tilt = np.array([state.stresses_and_tilt for state in contact_states])
    gap_by_stress_and_tilt, slip_by_stress_and_tilt = problem.gap_and_slip_by(stresses_and_tilt)
    gap_by_forces = gap - problem.initial_gap - gap_by_motion - gap_by_stress_and_tilt
    minus_slip_by_forces = slip_by_motion + slip_by_stress_and_tilt - slip
    elastic_energy = (pressure * gap_by_forces + shear * minus_slip_by_forces).sum(axis=1) / 2
    layer_energy = (
        pressure**2 @ problem.layer.normal_compliance
        + shear**2 @ problem.layer.tangential_compliance
    ) / 2
    return np.asarray(elastic_energy), np.asarray(layer_energy)


def increment_energies(
    problem: ContactProblem,
    contact_states: Sequence[InterfaceState],
    solved_by_increment: Sequence[States],
    areas_of_curve: Array | None = None,
) -> Energies:
    """Energies of the m increments between m + 1 contact states that follow each other: friction
    work, work of the loads, elastic energy and step errors, over P^2/E*.

    An increment solves the chord of the load path. What a curved path adds to the work of the loads
    is friction work.

    # notation: p, q nodal forces, pressure and shear; P, Q loads; U tangential displacement

    Parameters
    ----------
    problem
        the contact problem that the contact states solve; its `friction` is the coefficient f
    contact_states
        the m + 1 contact states, each with its loads and values: approach, U and tilt, then slip,
        p, q and gap of the n nodes
    solved_by_increment
        m arrays (n,): open, stick or slip of the nodes as each increment was solved, before a node
        that touches or lets go at its very end changes
    areas_of_curve
        (k, k, m) areas that a curved load path encloses with its chords, by pairs of k loads,
        scaled; None where the path is straight

    Returns
    -------
    Energies
        `dissipation` (m, n) is the friction work of each node. The others are of each increment,
        (m,). `loop_work`: Q dU, with the work of q in the slip by bulk stress. `external`: work of
        the loads along the chord; `curve`: what the curved path adds. `elastic`, `layer`: changes
        of the elastic energy, and of that of the penalty layer alone. `interface`: work of q in the
        slip minus that of p in the gap, by mean forces; `end_of_step`, `external_end_of_step`: both
        works by the forces and loads at the end. `step_error`: bound of the error of the friction
        work; `kink_work`: part of the friction work by kinks of p and slip.
    """
    solved_node_states = np.stack(solved_by_increment)
    increments = _Increments.between(contact_states, solved_node_states, problem.friction)
    movements = _Movements.between(contact_states)
    mean_p = (increments.p_at_start + increments.p_at_end) / 2
    mean_q = (increments.q_at_start + increments.q_at_end) / 2
    slip_sense = slip_sign(solved_node_states)  # 1 forward, -1 in reverse, 0 without slip

    # Friction work along the chord, with the share of the increment (`mean_onset`) after which
    # nodes start to slide; and Q dU.
    friction_work = _friction_work(problem, increments, slip_sense)
    loop_work = _loop_work_along_chord(
        problem.interface, increments, movements, slip_sense, friction_work
    )

    # Friction work that the curvature of the load path adds, (m, n); Q dU with its part of that.
    curve_work = np.zeros_like(increments.slip_change)
    if areas_of_curve is not None:
        curve_work, loop_work = _works_with_curve(
            problem, increments, slip_sense, areas_of_curve, friction_work, loop_work
        )

    elastic_energy, layer_energy = elastic_energies(problem, contact_states)
    return Energies(
        dissipation=friction_work.dissipation + curve_work,
        loop_work=loop_work,
        external=movements.work_of_loads(problem.interface, movements.mean_loads, mean_p, mean_q),
        external_end_of_step=movements.work_of_loads(
            problem.interface, movements.loads_at_end, increments.p_at_end, increments.q_at_end
        ),
        curve=curve_work.sum(axis=1),
        elastic=np.diff(elastic_energy),
        layer=np.diff(layer_energy),
        interface=increments.interface_work(mean_p, mean_q),
        end_of_step=increments.interface_work(increments.p_at_end, increments.q_at_end),
        step_error=step_errors(
            problem.friction,
            increments.p_at_end - increments.p_at_start,
            increments.slip_change,
            increments.node_states_before,
            increments.node_states_after,
        ),
        kink_work=friction_work.kink_work,
    )


class _FrictionWork(NamedTuple):
    """Friction work of m increments with n nodes along the chord of the load path, over P^2/E*.

    Attributes
    ----------
    dissipation
        (m, n) of each node
    kink_work
        (m,) part of it by kinks between the first onset of slip and the last, without sign: an
        onset is where a node starts to slide, and p and slip of all nodes change their rates
    mean_onset
        (m,) middle of the first and the last onset, a share of the increment; 1 where no node
        starts to slide
    """

    dissipation: Array
    kink_work: Array
    mean_onset: Array


def _friction_work(
    problem: ContactProblem, increments: _Increments, slip_sense: Indices
) -> _FrictionWork:
    """Friction work of m increments along the chord of the load path: f times the mean pressure p
    of each sliding node, times its slip.

    Where nodes start to slide in an increment (onsets), p and slip have kinks. Such increments are
    integrated in parts between the onsets. Also returned are the part of the work by kinks, and the
    middle of the first and last onset as a share of the increment, 1 without onsets.

    Parameters
    ----------
    problem
        the contact problem, with the friction coefficient f
    increments
        forces at start and end, slip and node states of n nodes in m increments
    slip_sense
        (m, n) 1 where a node slides forward as the increment was solved, -1 in reverse, 0 without
        slip
    """
    mean_p = (increments.p_at_start + increments.p_at_end) / 2
    dissipation = problem.friction * mean_p * np.maximum(slip_sense * increments.slip_change, 0.0)
    kink_work = np.zeros(len(slip_sense))
    mean_onset = np.ones(len(slip_sense))
    is_onset = is_slip_onset(increments.node_states_before, increments.node_states_after)
    numbers_with_onsets = np.flatnonzero(is_onset.any(axis=1))
    if len(numbers_with_onsets):
        work_with_onsets = _work_with_onsets(problem, increments.subset(numbers_with_onsets))
        dissipation[numbers_with_onsets] = work_with_onsets.dissipation
        kink_work[numbers_with_onsets] = work_with_onsets.kink_work
        mean_onset[numbers_with_onsets] = work_with_onsets.mean_onset
    return _FrictionWork(dissipation, kink_work, mean_onset)


def _loop_work_along_chord(
    interface: Interface,
    increments: _Increments,
    movements: _Movements,
    slip_sense: Indices,
    friction_work: _FrictionWork,
) -> Array:
    """Work Q dU of the tangential load in m increments, and of shear in the slip by bulk stress,
    along the chord of the load path, (m,), over P^2/E*. Round a steady cycle it is the friction
    work.

    The shear of a node that starts to slide has a kink in the increment, and the work of Q has it
    too. So Q dU differs from that with the mean Q by as much as the friction work differs from the
    mean shear times slip.

    Parameters
    ----------
    interface
        gives the slip at each node by a unit of bulk stress
    increments, movements
        shear and slip of n nodes; mean loads, and changes of U and of bulk stresses
    slip_sense
        (m, n) 1 where a node slides forward as the increment was solved, -1 in reverse, 0 without
        slip
    friction_work
        of each node, (m, n)
    """
    mean_q = (increments.q_at_start + increments.q_at_end) / 2
    work_with_mean_q = np.where(slip_sense != 0, mean_q * increments.slip_change, 0.0)
    loop_work = movements.mean_loads[:, 1] * movements.shift_change + (
        friction_work.dissipation - work_with_mean_q
    ).sum(axis=1)
    # pressure 0: the work of shear alone; per unit of both bulk stresses, then of tilt
    shear_work_per_unit = interface.work_per_stress_and_tilt(0 * mean_q, mean_q)
    loop_work += (shear_work_per_unit * movements.stress_and_tilt_change)[:, :2].sum(axis=1)
    return np.asarray(loop_work)


def _works_with_curve(
    problem: ContactProblem,
    increments: _Increments,
    slip_sense: Indices,
    areas_of_curve: Array,
    friction_work: _FrictionWork,
    loop_work: Array,
) -> tuple[Array, Array]:
    """Friction work of the nodes that the curvature of the load path adds to m increments, (m, n);
    and the work `loop_work` (m,) with its part of that: Q dU, with that of shear in the slip by
    bulk stress.

    The loads do what friction takes. A part of it is normal work, and the rest is in `loop_work`.

    Parameters
    ----------
    problem
        the contact problem, with the rates of pressure and slip by the loads
    increments
        with open, stick or slip of the n nodes before and after
    slip_sense
        (m, n) 1 where a node slides forward as the increment was solved, -1 in reverse, 0 without
        slip
    areas_of_curve
        (k, k, m) areas between path and chord, by pairs of the k loads
    friction_work, loop_work
        along the chord, which the increment solves
    """
    # while the nodes have their states from before the increment, and those after it
    work_before, work_after = _curve_work_by_node_states(
        problem, increments, slip_sense, friction_work.mean_onset, areas_of_curve
    )
    # friction only takes energy
    curve_work = np.maximum(
        work_before.dissipation + work_after.dissipation, -friction_work.dissipation
    )
    loop_work = loop_work - work_before.normal_work - work_after.normal_work
    return curve_work, loop_work + curve_work.sum(axis=1)


class _CurveWork(NamedTuple):
    """What the curvature of the load path adds to the work of m increments, over P^2/E*.

    Attributes
    ----------
    dissipation
        (m, n) to the friction work of each node
    normal_work
        (m,) to the work of the loads which is neither Q dU nor that of shear in the slip by bulk
        stress
    """

    dissipation: Array
    normal_work: Array


def _curve_work_by_node_states(
    problem: ContactProblem,
    increments: _Increments,
    slip_sense: Indices,
    mean_onset: Array,
    areas_of_curve: Array,
) -> tuple[_CurveWork, _CurveWork]:
    """What the curvature of the load path adds to the work of m increments in two parts: while the
    nodes have their states from before the increment, and those after it.

    The states before hold up to the share z of the increment at which nodes start to slide, those
    after from there on. Up to z, a parabola over its chord has z^2 (3 - 2 z) of its area.

    Parameters
    ----------
    problem
        the contact problem, with the rates of pressure and slip by the loads
    increments
        with open, stick or slip of the n nodes before and after
    slip_sense
        (m, n) 1 where a node slides forward as the increment was solved, -1 in reverse, 0 without
        slip
    mean_onset
        (m,) shares z, 1 where no node starts to slide
    areas_of_curve
        (k, k, m) areas between path and chord, by pairs of the k loads
    """
    area_share_before = mean_onset**2 * (3 - 2 * mean_onset)
    slides_already = slip_sense == slip_sign(increments.node_states_before)

    def work_of_part(node_states: States, sense: Indices, area_share: Array) -> _CurveWork:
        """Work that a share (m,) of the areas adds while the nodes have these states and senses of
        slip, (m, n) each.
        """
        curve_work = _CurveWork(np.zeros(slip_sense.shape), np.zeros(len(slip_sense)))
        numbers = np.flatnonzero(sense.any(axis=1) & (area_share > 0))
        added_work = _work_by_curve(
            problem,
            node_states[numbers],
            sense[numbers].astype(float),
            areas_of_curve[:, :, numbers] * area_share[numbers],
        )
        curve_work.dissipation[numbers] += added_work.dissipation
        curve_work.normal_work[numbers] += added_work.normal_work
        return curve_work

    return (
        work_of_part(
            increments.node_states_before,
            np.where(slides_already, slip_sense, 0),
            area_share_before,
        ),
        work_of_part(
            increments.node_states_after,
            slip_sign(increments.node_states_after),
            1 - area_share_before,
        ),
    )


def _without_idle_onsets(
    friction: float, node_states_before: States, node_states_after: States, slip: Array
) -> States:
    """States (...) of the nodes after increments. Nodes that are to start to slide and have not
    moved keep their state from before: at the Coulomb limit the last digit of the shear decides
    between both.

    `slip` (...) is that in the increment, scaled: up to 1e-11 times f (1 at most) a node has not
    moved. `friction` is the coefficient f.
    """
    # ROUNDING: round-off of scaled forces and displacements, 1e-11
    has_moved = np.abs(slip) > ROUNDING * min(friction, 1.0)
    is_idle_onset = is_slip_onset(node_states_before, node_states_after) & ~has_moved
    return np.where(is_idle_onset, node_states_before, node_states_after)


def work_by_kinks(
    problem: ContactProblem,
    start_state: InterfaceState,
    end_state: InterfaceState,
    solved_node_states: States,
) -> float:
    """Friction work that kinks of pressure and slip add in one increment, where nodes start to
    slide one after the other; without sign, over P^2/E*.

    Where a node starts to slide, the pressure and the slip of all nodes change their rates: a kink.
    Between kinks both are linear. The work is f times the integral of p ds minus (mean p) ds over
    the time between the first and the last kink.

    Parameters
    ----------
    problem
        the contact problem that both states solve
    start_state, end_state
        contact states before and after the increment
    solved_node_states
        (n,) open, stick or slip of the nodes as the increment was solved, before a node that
        touches or lets go at its very end changes
    """
    increment = _Increments.between(
        [start_state, end_state], solved_node_states[None], problem.friction
    )
    return float(_work_with_onsets(problem, increment).kink_work[0])


def _work_by_curve(
    problem: ContactProblem, node_states: States, slip_sense: Array, areas_of_curve: Array
) -> _CurveWork:
    """What the curvature of the load path adds to the work of m increments: to the dissipation of
    the nodes (m, n), and to the normal work (m,): that of the loads which is neither Q dU nor the
    work of shear in the slip by bulk stress.

    The nodes keep their states, so that p and s are linear in the loads. Along the curve, for each
    pair of loads F_i, F_j the dissipation of a node exceeds that along the chord by

        f (p_i s_j - p_j s_i) (int F_i dF_j of the curve - of the chord)

    # notation: subscripts of pressure p and slip s are derivatives by the loads; f friction

    Parameters
    ----------
    problem
        the contact problem; its `rates` are derivatives of approach, U and tilt, then of slip, p, q
        and gap of the nodes, by the k loads, (k, 3 + 4 n)
    node_states
        (m, n) open, stick or slip of the nodes, as they stay along the curve
    slip_sense
        (m, n) 1 where a node slides forward, -1 in reverse, 0 where it does not slide
    areas_of_curve
        (k, k, m) that the path encloses with its chord, by pairs of loads: integral of F_i dF_j
        along the path minus that along the chord; it changes sign where i and j are exchanged
    """
    n_loads = len(areas_of_curve)
    added_dissipation = np.zeros(slip_sense.shape)
    added_normal_work = np.zeros(len(slip_sense))
    load_pairs = np.argwhere(np.tril(areas_of_curve.any(axis=2))).tolist()  # each pair once
    if not load_pairs:
        return _CurveWork(added_dissipation, added_normal_work)
    rates = np.array([problem.rates(states, n_loads) for states in node_states])
    for i, j in load_pairs:
        rates_by_i = rates[:, i]
        rates_by_j = rates[:, j]
        slip_by_i, p_by_i, _, _ = nodal_values(rates_by_i)
        slip_by_j, p_by_j, _, _ = nodal_values(rates_by_j)
        area_of_pair = areas_of_curve[i, j]  # (m,)
        work_per_area = p_by_i * slip_by_j - p_by_j * slip_by_i
        added_dissipation += problem.friction * slip_sense * work_per_area * area_of_pair[:, None]
        # work of load i in the displacement by load j, minus that of j in the displacement by i
        normal_work_per_area = _normal_work_rate(
            problem, i, j, rates_by_i, rates_by_j
        ) - _normal_work_rate(problem, j, i, rates_by_j, rates_by_i)
        added_normal_work += normal_work_per_area * area_of_pair
    return _CurveWork(added_dissipation, added_normal_work)


def _work_with_onsets(problem: ContactProblem, increments: _Increments) -> _FrictionWork:
    """Friction work of the nodes in k increments in which some of them start to slide (onsets of
    slip): f times the integral of p ds, in parts between the onsets. Also the part of it by kinks,
    and the middle of the first and last onset.

    At an onset p and s have a kink, and all nodes that slide already slide faster from there on.
    With the mean p of the increment the work of a cycle is too large by 1e-4. So the increment is
    cut at its first onset and at its last one. What kinks between these two add is known where
    nodes start one after the other at nearly equal intervals.

    # notation: p pressure, s slip, f coefficient of friction

    Parameters
    ----------
    problem
        the contact problem: friction, and rates of its values by the loads at given node states
    increments
        pressure of the nodes at start and end, slip, node states before and after, (k, n) each
    """
    friction = problem.friction
    # A node that has just touched and starts to slide counts as sliding from the start.
    increments = increments._replace(node_states_before=_states_with_rates(increments))
    slip_sense = slip_sign(increments.node_states_after)

    # Changes of slip and p, as if the states before, or those after, held throughout the increment;
    # shares (k,) of the increment up to its first and its last onset.
    changes_before = _changes_at_constant_states(problem, increments, increments.node_states_before)
    changes_after = _changes_at_constant_states(problem, increments, increments.node_states_after)
    first_onset, last_onset = _first_and_last_onset(
        increments, changes_before, changes_after, friction
    )

    # Integrals of p ds: in three parts with p and s linear in each, and what kinks add to it.
    integral_of_parts = _integral_in_three_parts(
        increments, changes_before, changes_after, first_onset, last_onset
    )
    integral_of_kinks = _integral_of_kinks(
        increments, changes_before, changes_after, last_onset - first_onset
    )
    dissipation = friction * slip_sense * (integral_of_parts + integral_of_kinks)
    kink_work_of_nodes = friction * slip_sense * integral_of_kinks
    return _FrictionWork(
        dissipation=np.maximum(dissipation, 0.0),
        kink_work=np.abs(kink_work_of_nodes.sum(axis=1)),
        mean_onset=(first_onset + last_onset) / 2,
    )


def _integral_in_three_parts(
    increments: _Increments,
    changes_before: Array,
    changes_after: Array,
    first_onset: Array,
    last_onset: Array,
) -> Array:
    """Integral of p ds at the nodes in k increments, (k, n): to the first onset of slip, between
    the first and the last one, and from there on, with p and s linear in each part.

    Up to the first onset the node states from before the increment hold, from the last one on those
    after it. Both have known rates; what is left of the increment is the part between.

    # notation: p pressure, s slip

    Parameters
    ----------
    increments
        pressure of the nodes at start and end, and slip, (k, n) each
    changes_before, changes_after
        (4, k, n) changes of slip, p, q and gap if the states before, or those after, held
        throughout the increment
    first_onset, last_onset
        (k,) shares of the increment up to the first and the last onset
    """
    slip_change_before, p_change_before, _, _ = changes_before
    slip_change_after, p_change_after, _, _ = changes_after
    share_to_first_onset = first_onset[:, None]
    share_from_last_onset = 1 - last_onset[:, None]
    p_at_first_onset = increments.p_at_start + share_to_first_onset * p_change_before
    p_at_last_onset = increments.p_at_end - share_from_last_onset * p_change_after
    slip_to_first_onset = share_to_first_onset * slip_change_before
    slip_from_last_onset = share_from_last_onset * slip_change_after
    slip_between_onsets = increments.slip_change - slip_to_first_onset - slip_from_last_onset
    doubled_integral = (increments.p_at_start + p_at_first_onset) * slip_to_first_onset + (
        p_at_first_onset + p_at_last_onset
    ) * slip_between_onsets
    doubled_integral += (p_at_last_onset + increments.p_at_end) * slip_from_last_onset
    return np.asarray(doubled_integral / 2)


def _integral_of_kinks(
    increments: _Increments, changes_before: Array, changes_after: Array, share_between: Array
) -> Array:
    """What kinks between the first and the last onset of slip add to the integral of p ds at the
    nodes in k increments, (k, n).

    Between these onsets, a share z of the increment, m nodes start to slide one after the other at
    nearly equal intervals. Each changes the rates of p and s by 1/m of the way from those before to
    those after. With p and s linear from the first to the last onset the integral lacks

        [(m - 2)/(m - 1)] (z^2/12) (p'_before s'_after - p'_after s'_before).

    # notation: p pressure, s slip, p' and s' their changes in an increment at unchanged node states

    Parameters
    ----------
    increments
        open, stick or slip of the nodes before and after, (k, n); m are the neighbours in the
        longest run of nodes that start to slide
    changes_before, changes_after
        (4, k, n) changes of slip, p, q and gap if the states before, or those after, held
        throughout the increment
    share_between
        (k,) z
    """
    slip_change_before, p_change_before, _, _ = changes_before
    slip_change_after, p_change_after, _, _ = changes_after
    n_onsets = _length_of_longest_run(
        is_slip_onset(increments.node_states_before, increments.node_states_after)
    )
    kink_factor = np.maximum(n_onsets - 2, 0) / np.maximum(n_onsets - 1, 1) / 12
    return np.asarray(
        (share_between**2 * kink_factor)[:, None]
        * (p_change_before * slip_change_after - p_change_after * slip_change_before)
    )


def _changes_at_constant_states(
    problem: ContactProblem, increments: _Increments, states: States
) -> Array:
    """Changes (4, k, n) of slip, p, q and gap in k increments by the changes of the loads, if the
    nodes kept these `states` (k, n): rates by the loads times `increments.load_changes`.

    # notation: in subscripts of einsum k increments, j loads, v values
    """
    load_changes = increments.load_changes
    n_loads = load_changes.shape[1]
    rates = np.array([problem.rates(node_states, n_loads) for node_states in states])
    return nodal_values(np.einsum("kj,kjv->kv", load_changes, rates))


def _first_and_last_onset(
    increments: _Increments, changes_before: Array, changes_after: Array, friction: float
) -> tuple[Array, Array]:
    """Onsets of slip in k increments: shares (k,) of the increment after which the first node
    starts to slide, and the last one; both 0 where none starts.

    Forces and slip are linear between onsets. So the first node starts where its force to the
    Coulomb limit, f p - q in the sense of slip, has fallen to 0 at its rate before the onset.
    The last one has slid from its onset to the end of the increment, at the rate after.

    Parameters
    ----------
    increments
        p and q of the nodes at the start, slip, node states before and after, (k, n) each
    changes_before, changes_after
        (4, k, n) changes of slip, p, q and gap if the states before, or those after, held
        throughout the increment
    friction
        coefficient f
    """
    slip_sense = slip_sign(increments.node_states_after)
    is_onset = is_slip_onset(increments.node_states_before, increments.node_states_after)
    _, p_change_before, q_change_before, _ = changes_before
    slip_change_after, _, _, _ = changes_after
    with np.errstate(divide="ignore", invalid="ignore"):
        force_to_limit_at_start = force_to_limit(
            increments.p_at_start, increments.q_at_start, slip_sense, friction
        )
        change_of_force_to_limit = force_to_limit(
            p_change_before, q_change_before, slip_sense, friction
        )
        onset_share_by_force = force_to_limit_at_start / -change_of_force_to_limit
        onset_share_by_slip = 1 - increments.slip_change / slip_change_after
    onset_share_by_force = np.where(onset_share_by_force >= 0, onset_share_by_force, 1.0)
    # A node that slid the other way turns round at an unknown instant: the earliest is taken.
    onset_share_by_force = np.where(
        slip_sign(increments.node_states_before) != 0, 0.0, onset_share_by_force
    )
    first_onset = np.where(is_onset, onset_share_by_force, 1.0).min(axis=1).clip(0.0, 1.0)
    first_onset = np.where(is_onset.any(axis=1), first_onset, 0.0)
    is_known = is_onset & np.isfinite(onset_share_by_slip)
    last_onset = np.where(is_known, onset_share_by_slip, 0.0).max(axis=1).clip(first_onset, 1.0)
    return first_onset, last_onset


def _states_with_rates(increments: _Increments) -> States:
    """Node states (k, n) from before k increments, at which the rates up to the first onset of slip
    are taken: derivatives of slip, nodal forces and gaps by the loads.

    A node that has just touched and starts to slide counts as sliding already, unless no node would
    stick then: the bodies would be free to move, and there would be no rates.
    """
    is_onset = is_slip_onset(increments.node_states_before, increments.node_states_after)
    # ROUNDING: round-off of scaled forces and displacements, 1e-11
    has_just_touched = is_onset & (increments.p_at_start <= ROUNDING)
    states_if_sliding = np.where(
        has_just_touched, increments.node_states_after, increments.node_states_before
    )
    has_stick = (states_if_sliding == STICK).any(axis=1, keepdims=True)
    return np.where(has_stick, states_if_sliding, increments.node_states_before)


def _length_of_longest_run(is_onset: Mask) -> Indices:
    """Number (k,) of nodes in the longest run of neighbours that are True in each row of a mask
    (k, n).

    >>> _length_of_longest_run(np.array([[True, False, True, True, False]])).tolist()
    [2]
    """
    running_count = np.cumsum(is_onset, axis=1)
    count_at_run_begin = np.maximum.accumulate(np.where(is_onset, 0, running_count), axis=1)
    return np.asarray(np.max(running_count - count_at_run_begin, axis=1))


def _normal_work_rate(
    problem: ContactProblem, i: int, j: int, rates_by_i: Array, rates_by_j: Array
) -> Array:
    """Normal work (m,) at m instants: that of the forces by a unit of load i in the displacement by
    a unit of load j. It is the work of the loads that is neither Q dU nor the work of shear in the
    slip by bulk stress,

        dP/di d(approach)/dj - dM/di d(tilt)/dj,   with - sum dp/di G_j where j is a bulk stress

    # notation: M moment of the nodal forces, p pressure, G_j gap of the nodes by a unit of load j

    `rates_by_i` and `rates_by_j` (m, 3 + 4 n) are the derivatives of the contact's values by loads
    i and j: of approach, shift and tilt, then of slip, p, q and gap of the n nodes. Loads 0 to 4
    are P, Q, the bulk stresses of lower and upper body, tilt or moment.
    """
    _, p_by_i, q_by_i, _ = nodal_values(rates_by_i)
    approach_by_j = rates_by_j[:, 0]
    tilt_by_j = rates_by_j[:, 2]
    moment_by_i = problem.interface.moment(p_by_i, q_by_i)
    normal_load_by_i: Array | float = float(i == 0)
    if problem.actuators.prescribe_movements:  # P or Q is no load, but follows from movements
        normal_load_by_i, _ = problem.interface.resultants(p_by_i.T, q_by_i.T)
    work_rate = normal_load_by_i * approach_by_j - moment_by_i * tilt_by_j
    if j in (2, 3):  # a bulk stress
        pressure_work_per_stress = problem.interface.work_per_stress_and_tilt(p_by_i, 0 * q_by_i)
        work_rate = work_rate + pressure_work_per_stress[..., j - 2]
    return np.asarray(work_rate)


def law_violations(
    problem: ContactProblem, contact_states: Sequence[InterfaceState]
) -> dict[str, Array]:
    """Violations (m,) of the laws of contact and friction, and of equilibrium, at the ends of the m
    increments between m + 1 states; 0 where they are met.

    Forces, and forces times displacements, are over the largest nodal pressure at the instant, but
    at least a tenth of the mean one at the largest load: at the very first touch there is only
    round-off. Equilibrium, the imbalance of loads or of actuators' movements, is over the normal
    load at the instant. Displacements are over P/E*.

    Parameters
    ----------
    problem
        the contact problem: friction; `actuators`, of which each is the compliance of a rig whose
        movement stands in the place of P or Q, or None; whether the moment is given
    contact_states
        m + 1 states of the contact, each with its loads and values

    Returns
    -------
    dict
        "equilibrium", and the laws: "tension" (negative pressure), "penetration" (negative gap),
        "gap_pressure" (gap times pressure), "cone" (shear beyond the Coulomb limit), "slip_sign"
        (work of slip against the shear), "creep" (slip below the limit).
    """
    values = np.stack([state.values for state in contact_states])
    slip, pressure, shear, gap = nodal_values(values)
    slip_increment = np.diff(slip, axis=0)
    # at the ends of the increments: the first state is where they start
    loads = np.array([state.loads for state in contact_states])[1:]
    pressure = pressure[1:]
    shear = shear[1:]
    gap = gap[1:]
    # 1/n is the mean nodal pressure at the largest load, scaled to 1
    largest_force = np.maximum(pressure.max(axis=1), 0.1 / pressure.shape[1])
    violation_by_name = violations(gap, pressure, shear, slip_increment, problem.friction)
    for name in ("tension", "gap_pressure", "cone", "slip_sign"):
        violation_by_name[name] = violation_by_name[name] / largest_force

    equilibrium_violation = _equilibrium_violation(problem, values[1:], pressure, shear, loads)
    return {"equilibrium": equilibrium_violation, **violation_by_name}


def _equilibrium_violation(
    problem: ContactProblem, values: Array, pressure: Array, shear: Array, loads: Array
) -> Array:
    """Largest imbalance of the loads, or of actuators' movements, over the normal load, at m
    instants, (m,); with the moment where that is given.

    An actuator's movement in the place of a load is the rigid motion of the upper body (approach,
    or U) and what the rig gives way.

    Parameters
    ----------
    problem
        the contact problem: `actuators`, of which each is the compliance of a rig whose movement
        stands in the place of P or Q, or None; whether the moment is given
    values
        (m, 3 + 4 n) values of the contact states: approach and U first
    pressure, shear
        (m, n) nodal forces
    loads
        (m, n_loads) P and Q, or movements in their place; the moment last
    """
    normal_resultant, tangential_resultant = problem.interface.resultants(pressure.T, shear.T)
    loads_reached = [normal_resultant, tangential_resultant]
    for number, rig_compliance in enumerate(problem.actuators):
        if rig_compliance is not None:
            rigid_motion = values[:, number]
            loads_reached[number] = rigid_motion + rig_compliance * loads_reached[number]
    imbalance = np.abs(np.array(loads_reached) - loads[:, :2].T).max(axis=0)
    if problem.has_given_moment:
        moment = problem.interface.moment(pressure, shear)
        imbalance = np.maximum(imbalance, np.abs(moment - loads[:, -1]))
    normal_load = normal_resultant if problem.actuators.prescribe_approach else loads[:, 0]
    return np.asarray(imbalance / np.maximum(normal_load, 1e-300))
