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

from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState, nodal
from halfplane_fe.law import force_to_limit, slip_sign, violations
from scenes import STICK
from scenes.array_types import Array, Indices, Mask, States


@dataclass(frozen=True, eq=False)
class Energies:
    """Energies of m increments (over P^2/E*), each (m,), and the dissipation of their nodes (m, n).

    Attributes
    ----------
    dissipation
        f p |ds| of each sliding node, p being the mean of the increment, or of its parts before
        and after nodes start to slide, and what the curve of the loads adds
    loop
        integral of Q dU along the curve of the loads, and of q in the slip by bulk stress (-m_q
        d(eps) of half-planes)
    external
        work of P, Q, bulk stresses and tilt along the chord
    curve
        what the curve of the loads adds to it, all of it friction work
    external_end_of_step
        the same with the loads at the end of the increment
    elastic
        change of elastic energy, that of the penalty layer included
    layer
        change of the energy of the penalty layer
    interface
        trapezoidal work of shear minus that of pressure
    end_of_step
        the same with the forces at the end of the increment
    step_error
        bound of the error of the dissipation, see `step_errors`
    bent
        part of the dissipation of three nodes and more that start to slide, see `_kinked_work`:
        its error is less
    """

    dissipation: Array
    loop: Array
    external: Array
    external_end_of_step: Array
    curve: Array
    elastic: Array
    layer: Array
    interface: Array
    end_of_step: Array
    step_error: Array
    bent: Array


def elastic_energies(
    problem: ContactProblem, states: Sequence[InterfaceState]
) -> tuple[Array, Array]:
    """Elastic energy of both bodies and of the layer between them, and that of the layer alone, at
    m states of the interface of a contact `problem`, (m,) each, over P^2/E*.
    """
    values = np.stack([state.values for state in states])
    slip, pressure, shear, gap = nodal(values)
    gap_moved, slip_moved = problem.interface.moved(values[:, 0, None], values[:, 1, None])
    gap_imposed, slip_imposed = problem.offsets(np.array([state.imposed for state in states]))
    gap_part = gap - problem.height - gap_moved - gap_imposed  # N p - K^T q
    slip_part = slip_moved + slip_imposed - slip  # T q - K p
    layer_energy = (pressure**2 @ problem.layer.normal + shear**2 @ problem.layer.tangential) / 2
    return np.asarray((pressure * gap_part + shear * slip_part).sum(axis=1) / 2), np.asarray(
        layer_energy
    )


def _starting(states_before: States, states_after: States) -> Mask:
    """Which nodes start to slide, or turn round: they slide after an increment and did not slide
    that way before.
    """
    sign = slip_sign(states_after)
    return (sign != 0) & (sign != slip_sign(states_before))


def step_errors(
    friction: float, pressure: Array, slip: Array, states_before: States, states_after: States
) -> Array:
    """Bound (...) of the error of the dissipation: f |dp| |ds| / 2 of the nodes that start to slide
    in the increment.

    `pressure` and `slip` are the changes of the increment, `before` and `after` the states, each
    (..., n).
    """
    products = np.where(_starting(states_before, states_after), np.abs(pressure * slip), 0.0)
    return np.asarray(friction * products.sum(axis=-1) / 2)


def increment_energies(
    problem: ContactProblem,
    states: Sequence[InterfaceState],
    solved_by_increment: Sequence[States],
    areas_of_curve: Array | None = None,
) -> Energies:
    """Energies of the increments between m + 1 states that follow each other: friction work, work
    of the loads, elastic energy and step errors, (m,) or (m, n) each.

    Parameters
    ----------
    problem
        the contact problem that the states solve
    states
        the m + 1 states
    solved_by_increment
        (m,) of arrays (n,): the states of the nodes at the end of each increment, before an
        event changes them
    areas_of_curve
        (k, k, m) areas that a curved load path encloses with its chords, by pairs of k loads
        over their units; None for straight increments
    """
    interface = problem.interface
    values = np.stack([state.values for state in states])
    loads = np.array([(state.normal_load, state.tangential_load) for state in states])
    imposed_motion = np.diff([state.imposed for state in states], axis=0)
    _, p, q, _ = nodal(values)
    mean_p = (p[:-1] + p[1:]) / 2
    mean_q = (q[:-1] + q[1:]) / 2
    mean_load = (loads[:-1] + loads[1:]) / 2
    changes = np.diff(values, axis=0)
    approach = changes[:, 0]
    shift = changes[:, 1]
    slip, pressure, _, gap = nodal(changes)

    def load_work(loads: Array, p: Array, q: Array) -> Array:
        imposed_work = (interface.work_of_imposed(p, q) * imposed_motion).sum(axis=1)
        return np.asarray(loads[:, 0] * approach + loads[:, 1] * shift + imposed_work)

    states_before = np.stack([state.state for state in states[:-1]])
    solved_states = np.stack(solved_by_increment)
    slip_signs = slip_sign(solved_states)
    dissipation = problem.friction * mean_p * np.maximum(slip_signs * slip, 0.0)
    states_after = _states_of_moved(problem.friction, states_before, solved_states, slip)
    kinked_rows = np.flatnonzero(_starting(states_before, states_after).any(axis=1))
    bent_works = np.zeros(len(slip_signs))
    share_before = np.ones(len(slip_signs))
    if len(kinked_rows):
        dissipation[kinked_rows], bent_works[kinked_rows], share_before[kinked_rows] = _kinked_work(
            problem,
            _changes_of_loads(states)[kinked_rows],
            _Rows(p, q, slip, states_before, states_after),
            kinked_rows,
        )
    # The shear of a node that starts to slide has a kink in the increment, and the work of Q with
    # it.
    trapezoidal_works = np.where(slip_signs != 0, mean_q * slip, 0.0)
    loop_works = mean_load[:, 1] * shift + (dissipation - trapezoidal_works).sum(axis=1)
    loop_works += (interface.work_of_imposed(0 * mean_p, mean_q) * imposed_motion)[:, :2].sum(
        axis=1
    )
    works_by_curve = np.zeros_like(slip)
    if areas_of_curve is not None:
        # The states before hold for a share of the increment, those after for the rest: of the area
        # of a parabola over its chord they have this.
        weight_before = share_before**2 * (3 - 2 * share_before)
        directions_before = np.where(slip_signs == slip_sign(states_before), slip_signs, 0)
        for node_states, slip_directions, weights in (
            (states_before, directions_before, weight_before),
            (states_after, slip_sign(states_after), 1 - weight_before),
        ):
            row_numbers = np.flatnonzero(slip_directions.any(axis=1) & (weights > 0))
            enclosed_areas = areas_of_curve[:, :, row_numbers] * weights[row_numbers]
            float_directions = slip_directions[row_numbers].astype(float)
            node_works, loop_parts = _work_by_curve(
                problem, node_states[row_numbers], float_directions, enclosed_areas
            )
            works_by_curve[row_numbers] += node_works
            loop_works[row_numbers] -= loop_parts
        works_by_curve = np.maximum(works_by_curve, -dissipation)  # friction only takes
        loop_works += works_by_curve.sum(axis=1)
    elastic_energy, layer_energy = elastic_energies(problem, states)
    return Energies(
        dissipation=dissipation + works_by_curve,
        loop=loop_works,
        external=load_work(mean_load, mean_p, mean_q),
        external_end_of_step=load_work(loads[1:], p[1:], q[1:]),
        curve=works_by_curve.sum(axis=1),
        elastic=np.diff(elastic_energy),
        layer=np.diff(layer_energy),
        interface=(mean_q * slip - mean_p * gap).sum(axis=1),
        end_of_step=(q[1:] * slip - p[1:] * gap).sum(axis=1),
        step_error=step_errors(problem.friction, pressure, slip, states_before, states_after),
        bent=bent_works,
    )


def _changes_of_loads(states: Sequence[InterfaceState]) -> Array:
    """(m, k) of the k loads, or movements in their place."""
    return np.diff([state.loads for state in states], axis=0)


def _states_of_moved(
    friction: float, states_before: States, states_after: States, slip: Array
) -> States:
    """(...) states after; of nodes that are to start sliding and have not moved those before: on
    the cone a node is marked either way, by the last digit of its shear.
    """
    has_moved = np.abs(slip) > ROUNDING * min(friction, 1.0)
    return np.where(
        _starting(states_before, states_after) & ~has_moved, states_before, states_after
    )


def bent_work(
    problem: ContactProblem, start: InterfaceState, end: InterfaceState, solved: States
) -> float:
    """Dissipation that kinks between the first and the last start of sliding add to one increment
    from `start` to `end`, without sign [energy, scaled].

    `problem` is the contact problem that both states solve; `solved` (n,) are the states of the
    nodes at the end, before an event changes them. p and q are the nodal forces, pressure and
    shear.
    """
    values = np.stack([start.values, end.values])
    _, p, q, _ = nodal(values)
    slip = end.slip - start.slip
    states_after = _states_of_moved(problem.friction, start.state, solved, slip)
    increment = _Rows(p, q, slip[None], start.state[None], states_after[None])
    changes_of_loads = np.subtract(end.loads, start.loads)[None]
    _, bent, _ = _kinked_work(problem, changes_of_loads, increment, np.array([0]))
    return float(bent[0])


def _work_by_curve(
    problem: ContactProblem, node_states: States, directions: Array, areas: Array
) -> tuple[Array, Array]:
    """What the curve of the loads adds to increments: friction work (m, n) of the nodes, and the
    work (m,) of pressure and P that is no work of Q.

    Parameters
    ----------
    node_states
        (m, n) states that hold
    directions
        (m, n) sense of slip of the nodes that slide, 1 or -1, else 0
    areas
        (k, k, m) that the curve encloses with its chord, for each pair of loads
    """
    n_loads = len(areas)
    node_works = np.zeros(directions.shape)
    loop_parts = np.zeros(len(directions))
    pairs = np.argwhere(np.tril(areas.any(axis=2))).tolist()
    if not pairs:
        return node_works, loop_parts
    rates_by_load = np.array([problem.rates(states, n_loads) for states in node_states])
    for i, j in pairs:
        by_i = rates_by_load[:, i]
        by_j = rates_by_load[:, j]
        slip_by_i, p_by_i, _, _ = nodal(by_i)
        slip_by_j, p_by_j, _, _ = nodal(by_j)
        area = areas[i, j]
        skew_rates = p_by_i * slip_by_j - p_by_j * slip_by_i
        node_works += problem.friction * directions * skew_rates * area[:, None]
        normal_work = _normal_work(problem, i, j, by_i, by_j)
        loop_parts += (normal_work - _normal_work(problem, j, i, by_j, by_i)) * area
    return node_works, loop_parts


class _Rows(NamedTuple):
    """Increments between m + 1 states: forces p and q (m + 1, n), changes of slip (m, n), states of
    the nodes before and after (m, n).
    """

    p: Array
    q: Array
    slip: Array
    before: States
    after: States


def _kinked_work(
    problem: ContactProblem, changes_of_loads: Array, increments: _Rows, rows: Indices
) -> tuple[Array, Array, Array]:
    """Friction work of each node in increments of a contact `problem` in which nodes start to
    slide, its part by kinks between the first and the last start, and the share of the increment up
    to their middle.

    Where a node starts, p and s have a kink, and all that slides already goes faster from there on:
    with the mean p of the increment W is too large, by 1e-4 of a cycle. Up to the first start the
    states before hold, from the last one on those after, and both have known rates. That is all
    where one node starts, or two. The first start is where the edge of stick meets the first node,
    the last one where it meets the last, by the two distances of `between_nodes.Edge`: forces to
    the Coulomb limit and slip, each over its rate.

    In between, a share z of the increment, n nodes start one after the other in much the same
    distances: n - 2 kinks, each with an area u (1 - u) z^2/2 over the chord, u the share of z up to
    it. With rates ' per increment, those of slip growing alike,

        int p ds - (mean p) ds = [(n - 2)/(n - 1)] (z^2/12) (p'_before s'_after - p'_after
        s'_before).

    Parameters
    ----------
    changes_of_loads
        (k, n_loads) in the increments of these rows
    rows
        (k,) increments

    Returns
    -------
    tuple[Array, Array, Array]
        work (k, n); the part (k,) of the last formula, without sign; share (k,)
    """
    friction = problem.friction
    slip_change = increments.slip[rows]
    p_at_start = increments.p[rows]
    p_at_end = increments.p[rows + 1]
    states_after = increments.after[rows]
    states_before = _states_with_rates(increments.before[rows], states_after, p_at_start)
    slip_directions = slip_sign(states_after)
    is_starting = _starting(states_before, states_after)
    n_loads = changes_of_loads.shape[1]
    rates_before = np.array([problem.rates(states, n_loads) for states in states_before])
    rates_after = np.array([problem.rates(states, n_loads) for states in states_after])
    slip_change_before, p_change_before, q_change_before, _ = nodal(
        np.einsum("kj,kjv->kv", changes_of_loads, rates_before)
    )
    slip_change_after, p_change_after, _, _ = nodal(
        np.einsum("kj,kjv->kv", changes_of_loads, rates_after)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        # f p -+ q falls to zero where a node starts; its slip goes back to zero there.
        distance = force_to_limit(p_at_start, increments.q[rows], slip_directions, friction)
        change = force_to_limit(p_change_before, q_change_before, slip_directions, friction)
        first_start = distance / -change
        last_start = 1 - slip_change / slip_change_after
    # What slid the other way turns round somewhere.
    first_start = np.where(first_start >= 0, first_start, 1.0)
    first_start = np.where(slip_sign(states_before) != 0, 0.0, first_start)
    first_start = np.where(is_starting, first_start, 1.0).min(axis=1).clip(0.0, 1.0)
    first_start = np.where(is_starting.any(axis=1), first_start, 0.0)
    last_start = (
        np.where(is_starting & np.isfinite(last_start), last_start, 0.0)
        .max(axis=1)
        .clip(first_start, 1.0)
    )
    share_before = first_start[:, None]
    share_after = 1 - last_start[:, None]
    p_at_first = p_at_start + share_before * p_change_before
    p_at_last = p_at_end - share_after * p_change_after
    slip_to_first = share_before * slip_change_before
    slip_from_last = share_after * slip_change_after
    slip_between = slip_change - slip_to_first - slip_from_last
    doubled_work = (p_at_start + p_at_first) * slip_to_first + (
        p_at_first + p_at_last
    ) * slip_between
    doubled_work += (p_at_last + p_at_end) * slip_from_last
    n_starts = _longest_row(is_starting)
    kink_factor = np.maximum(n_starts - 2, 0) / np.maximum(n_starts - 1, 1) / 12
    bent_work = ((last_start - first_start) ** 2 * kink_factor)[:, None] * (
        p_change_before * slip_change_after - p_change_after * slip_change_before
    )
    node_work = friction * slip_directions * (doubled_work / 2 + bent_work)
    bent_work = friction * slip_directions * bent_work
    return np.maximum(node_work, 0.0), np.abs(bent_work.sum(axis=1)), (first_start + last_start) / 2


def _states_with_rates(states_before: States, states_after: States, pressure: Array) -> States:
    """(k, n) states before, but a node that has just touched slides from there on; unless it is the
    last to stick: then no set has rates.
    """
    just_touched = _starting(states_before, states_after) & (pressure <= ROUNDING)
    sliding_on = np.where(just_touched, states_after, states_before)
    some_stick = (sliding_on == STICK).any(axis=1, keepdims=True)
    return np.where(some_stick, sliding_on, states_before)


def _longest_row(starts: Mask) -> Indices:
    """(k,) nodes of the longest row of neighbours that are True."""
    running_count = np.cumsum(starts, axis=1)
    count_at_row_begin = np.maximum.accumulate(np.where(starts, 0, running_count), axis=1)
    return np.asarray(np.max(running_count - count_at_row_begin, axis=1))


def _normal_work(
    problem: ContactProblem, i: int, j: int, rates_by_i: Array, rates_by_j: Array
) -> Array:
    """(m,) work of normal tractions per unit of load i and unit of change of load j:
    dP/di d(approach)/dj + dM/di d(tilt)/dj, and of a bulk stress j what it does on dp/di.

    `rates_by_i` and `rates_by_j` (m, 3 + 4 n) are the derivatives of the contact's values by loads
    i and j at m instants: of approach, shift and tilt, then of slip, p, q and gap of the n nodes.
    """
    _, p_by_i, q_by_i, _ = nodal(rates_by_i)
    approach_by_j = rates_by_j[:, 0]
    tilt_by_j = rates_by_j[:, 2]
    moment_by_i = problem.interface.work_of_imposed(p_by_i, q_by_i)[..., 2]
    normal_load_by_i: Array | float = float(i == 0)
    if problem.actuators.are_there:
        normal_load_by_i, _ = problem.interface.carried(p_by_i.T, q_by_i.T)
    work_rate = normal_load_by_i * approach_by_j + moment_by_i * tilt_by_j
    if j in (2, 3):  # a bulk stress
        work_by_bulk_stresses = problem.interface.work_of_imposed(p_by_i, 0 * q_by_i)
        work_rate = work_rate + work_by_bulk_stresses[..., j - 2]
    return np.asarray(work_rate)


def certificates(problem: ContactProblem, states: Sequence[InterfaceState]) -> dict[str, Array]:
    """Violations (m,) of law and equilibrium at the ends of increments, over the largest nodal
    force and its work.

    The force is at least a tenth of the mean one at the largest load: at the very first touch there
    is nothing but rounding.
    """
    values = np.stack([state.values for state in states])
    loads = np.array([state.loads for state in states])[1:]
    slip, pressure, shear, gap = nodal(values)
    slip_increment = np.diff(slip, axis=0)
    # the first state is where the increments start
    pressure = pressure[1:]
    shear = shear[1:]
    gap = gap[1:]
    force = np.maximum(pressure.max(axis=1), 0.1 / pressure.shape[1])
    of_law = violations(gap, pressure, shear, slip_increment, problem.friction)
    for name in ("tension", "gap_pressure", "cone", "slip_sign"):
        of_law[name] = of_law[name] / force
    normal_load, tangential_load = problem.interface.carried(pressure.T, shear.T)
    loads_reached = [normal_load, tangential_load]
    # What stands in the place of a load is a movement: a rigid motion and what the rig gives way.
    for number, compliance in enumerate(problem.actuators):
        if compliance is not None:
            loads_reached[number] = values[1:, number] + compliance * loads_reached[number]
    equilibrium = np.abs(np.array(loads_reached) - loads[:, :2].T).max(axis=0)
    if problem.moment_given:
        moment = -problem.interface.work_of_imposed(pressure, shear)[:, 2]
        equilibrium = np.maximum(equilibrium, np.abs(moment - loads[:, -1]))
    largest_load = loads[:, 0] if problem.actuators.normal is None else normal_load
    return {"equilibrium": equilibrium / np.maximum(largest_load, 1e-300), **of_law}
