"""Energy balance and Coulomb certificates of increments: checks that need no reference. Scaled,
like `contact`.

With loads, forces and displacements taken at the middle of the increment the balance

    P d(delta) + Q dU + sum F_i de_i = d(elastic energy) + sum q ds - sum p dg,   F = S q - G p

is an identity of the discrete problem: a check of the algebra. Here e are the bulk stresses and the
tilt, and F de is -m_q d(eps)
- M d(alpha) of half-planes, see `interface`. What the increment itself costs shows in the three
ways to write the friction work: at its middle (f p ds), trapezoidal (q ds), at its end (first
order). The work of the loads at its end,
P d(delta) + Q dU with the new P and Q, has the normal part of that error in it: on the interface
there is none, because increments land on each touch and release, so that p dg is zero in each.

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

import numpy as np

from halfplane_fe.arrays import Array, Indices, Mask, States
from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState, nodal
from halfplane_fe.law import slip_sign, violations
from scenes import STICK


@dataclass(frozen=True, eq=False)
class Energies:
    """Energies of m increments (over P^2/E*), each (m,), and the dissipation of their nodes (m, n).

    Attributes
    ----------
    dissipation : f p |ds| of each sliding node, p being the mean of the increment, or of its parts
        before and after nodes start to slide, and what the curve of the loads adds
    loop : integral of Q dU along the curve of the loads, and of q in the slip by bulk stress (-m_q
    d(eps) of half-planes) external : work of P, Q, bulk stresses and tilt along the chord
    curve : what the curve of the loads adds to it, all of it friction work
    external_end_of_step : the same with the loads at the end of the increment
    elastic : change of elastic energy, that of the penalty layer included
    layer : change of the energy of the penalty layer
    interface : trapezoidal work of shear less that of pressure
    end_of_step : the same with the forces at the end of the increment
    step_error : bound of the error of the dissipation, see `step_errors`
    bent : part of the dissipation of three nodes and more that start to slide, see `_kinked_work`:
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
    """Elastic energy (m,) of both bodies and of the layer between them, and that of the layer
    alone.
    """
    values = np.stack([state.values for state in states])
    slip, p, q, gap = nodal(values)
    gap_moved, slip_moved = problem.interface.moved(values[:, 0, None], values[:, 1, None])
    gap_imposed, slip_imposed = problem.offsets(np.array([state.imposed for state in states]))
    gap_part = gap - problem.height - gap_moved - gap_imposed  # N p - K^T q
    slip_part = slip_moved + slip_imposed - slip  # T q - K p
    layer = (p**2 @ problem.layer.normal + q**2 @ problem.layer.tangential) / 2
    return np.asarray((p * gap_part + q * slip_part).sum(axis=1) / 2), np.asarray(layer)


def _starting(before: States, after: States) -> Mask:
    """Which nodes start to slide, or turn round: they slide after an increment and did not slide
    that way before.
    """
    sign = slip_sign(after)
    return (sign != 0) & (sign != slip_sign(before))


def step_errors(
    friction: float, pressure: Array, slip: Array, before: States, after: States
) -> Array:
    """Bound (...) of the error of the dissipation: f |dp| |ds| / 2 of the nodes that start to slide
    in the increment.

    `pressure` and `slip` are the changes of the increment, `before` and `after` the states, each
    (..., n).
    """
    return np.asarray(
        friction * np.where(_starting(before, after), np.abs(pressure * slip), 0.0).sum(axis=-1) / 2
    )


def increment_energies(
    problem: ContactProblem,
    states: Sequence[InterfaceState],
    solved: Sequence[States],
    enclosed: Array | None = None,
) -> Energies:
    """Energies of the increments between m + 1 states that follow each other.

    Parameters
    ----------
    solved : (m,) of arrays (n,): the states of the nodes at the end of each increment, before an
    event changes them enclosed : (k, k, m) see `path`, over the units of the loads
    """
    values, loads = (
        np.stack([state.values for state in states]),
        np.array([state.loads for state in states]),
    )
    p, q = nodal(values)[1:3]
    mean_p, mean_q = (p[:-1] + p[1:]) / 2, (q[:-1] + q[1:]) / 2
    mean_load, changes = (loads[:-1] + loads[1:]) / 2, np.diff(values, axis=0)
    slip, pressure, _, gap = nodal(changes)
    approach, shift = changes[:, 0], changes[:, 1]
    imposed, faces = np.diff([state.imposed for state in states], axis=0), problem.interface
    before, after = np.stack([state.state for state in states[:-1]]), np.stack(solved)

    def work(loads: Array, p: Array, q: Array) -> Array:
        of_imposed = (faces.work_of_imposed(p, q) * imposed).sum(axis=1)
        return np.asarray(loads[:, 0] * approach + loads[:, 1] * shift + of_imposed)

    sign, sign_before = slip_sign(after), slip_sign(before)
    dissipation = problem.friction * mean_p * np.maximum(sign * slip, 0.0)
    starts = _starting(before, after)
    # A node on the cone that has not moved is marked either way, by the last digit of its shear.
    moved = np.abs(slip) > ROUNDING * min(problem.friction, 1.0)
    after, starts = np.where(starts & ~moved, before, after), starts & moved
    kinked, bent, share = (
        np.flatnonzero(starts.any(axis=1)),
        np.zeros(len(sign)),
        np.ones(len(sign)),
    )
    if len(kinked):
        dissipation[kinked], bent[kinked], share[kinked] = _kinked_work(
            problem, loads, (p, q), slip, (before, after), kinked
        )
    # The shear of a node that starts to slide has a kink in the increment, and the work of Q with
    # it.
    loop = mean_load[:, 1] * shift + (dissipation - np.where(sign != 0, mean_q * slip, 0.0)).sum(
        axis=1
    )
    loop += (faces.work_of_imposed(0 * mean_p, mean_q) * imposed)[:, :2].sum(axis=1)
    curve = np.zeros_like(slip)
    if enclosed is not None:
        # The states before hold for a share of the increment, those after for the rest: of the area
        # of a parabola over its chord they have this.
        early = share**2 * (3 - 2 * share)
        for sets, factor, weight in (
            (before, np.where(sign == sign_before, sign, 0), early),
            (after, slip_sign(after), 1 - early),
        ):
            rows = np.flatnonzero(factor.any(axis=1) & (weight > 0))
            pairs = np.argwhere(np.tril(enclosed[:, :, rows].any(axis=2))).tolist()
            rates = (
                [problem.rates(sets[row], len(enclosed)) for row in rows.tolist()] if pairs else []
            )
            for i, j in pairs:
                area = enclosed[i, j, rows] * weight[rows]
                one, other = (np.stack([found[load] for found in rates]) for load in (i, j))
                (s_i, p_i, *_), (s_j, p_j, *_) = nodal(one), nodal(other)
                curve[rows] += (
                    problem.friction * factor[rows] * (p_i * s_j - p_j * s_i) * area[:, None]
                )
                loop[rows] -= (
                    _normal_work(problem, i, j, one, other)
                    - _normal_work(problem, j, i, other, one)
                ) * area
        curve = np.maximum(curve, -dissipation)  # friction only takes
        loop += curve.sum(axis=1)
    elastic, layer = elastic_energies(problem, states)
    return Energies(
        dissipation=dissipation + curve,
        loop=loop,
        external=work(mean_load, mean_p, mean_q),
        external_end_of_step=work(loads[1:], p[1:], q[1:]),
        curve=curve.sum(axis=1),
        elastic=np.diff(elastic),
        layer=np.diff(layer),
        interface=(mean_q * slip - mean_p * gap).sum(axis=1),
        end_of_step=(q[1:] * slip - p[1:] * gap).sum(axis=1),
        step_error=step_errors(problem.friction, pressure, slip, before, after),
        bent=bent,
    )


def _kinked_work(
    problem: ContactProblem,
    loads: Array,
    forces: tuple[Array, Array],
    slip: Array,
    sets: tuple[States, States],
    rows: Indices,
) -> tuple[Array, Array, Array]:
    """Friction work of increments in which nodes start to slide, its part by kinks in between, the
    share of the states before.

    Where a node starts, p and s have a kink, and all that slides already goes faster from there on:
    with the mean p of the whole increment W is too large, by 1e-4 of a cycle. Up to the first start
    the states before hold, from the last one on those after, and both have known rates. That is all
    where one node starts, or two.

    In between, a share z of the increment, n nodes start one after the other in much the same
    distances: n - 2 kinks, each with an area u (1 - u) z^2/2 over the chord, u the share of z up to
    it. With rates ' per increment, those of slip growing alike,

        int p ds - (mean p) ds = [(n - 2)/(n - 1)] (z^2/12) (p'_before s'_after - p'_after
        s'_before).

    Parameters
    ----------
    forces : p and q, (m + 1, n) each
    slip : (m, n) changes
    sets : states (m, n) before and after
    rows : (k,) increments

    Returns
    -------
    work (k, n); the part (k,) of the last formula, without sign; share (k,)
    """
    (p, q), after = forces, sets[1][rows]
    # A node that has just touched slides from there on; where it is the last to stick, it has no
    # rates so.
    before = np.where(_starting(sets[0][rows], after) & (p[rows] <= ROUNDING), after, sets[0][rows])
    before = np.where((before == STICK).any(axis=1, keepdims=True), before, sets[0][rows])
    sign, starts = slip_sign(after), _starting(before, after)
    rates = np.stack(
        [
            [problem.rates(one, loads.shape[1]) for one in pair]
            for pair in zip(before, after, strict=True)
        ]
    )
    early, late = np.moveaxis(np.einsum("kj,ksjv->ksv", np.diff(loads, axis=0)[rows], rates), 1, 0)
    (slip_early, p_early, q_early, _), (slip_late, p_late, *_) = nodal(early), nodal(late)
    with np.errstate(divide="ignore", invalid="ignore"):
        # f p -+ q falls to zero where a node starts; its slip goes back to zero there.
        first = (problem.friction * p[rows] - sign * q[rows]) / (
            sign * q_early - problem.friction * p_early
        )
        last = 1 - slip[rows] / slip_late
    # What slid the other way turns round somewhere.
    first = np.where(slip_sign(before) != 0, 0.0, np.where(first >= 0, first, 1.0))
    first = np.where(
        starts.any(axis=1), np.where(starts, first, 1.0).min(axis=1).clip(0.0, 1.0), 0.0
    )
    last = np.where(starts & np.isfinite(last), last, 0.0).max(axis=1).clip(first, 1.0)
    t, rest = first[:, None], 1 - last[:, None]
    count = np.cumsum(starts, axis=1)
    # of the longest row of neighbours
    number = np.max(count - np.maximum.accumulate(np.where(starts, 0, count), axis=1), axis=1)
    within = (last - first) ** 2 * np.maximum(number - 2, 0) / np.maximum(number - 1, 1) / 12
    bent = within[:, None] * (p_early * slip_late - p_late * slip_early)
    p_first, p_last = p[rows] + t * p_early, p[rows + 1] - rest * p_late
    doubled = (p[rows] + p_first) * t * slip_early + (p_first + p_last) * (
        slip[rows] - t * slip_early - rest * slip_late
    )
    doubled += (p_last + p[rows + 1]) * rest * slip_late
    work, bent = (problem.friction * sign * part for part in (doubled / 2 + bent, bent))
    return np.maximum(work, 0.0), np.abs(bent.sum(axis=1)), (first + last) / 2


def _normal_work(problem: ContactProblem, i: int, j: int, one: Array, other: Array) -> Array:
    """(m,) work per unit of load i times change of load j, without that of shear: P in the
    approach, p in bulk stress and tilt.

    `one` and `other` (m, 3 + 4 n) are the derivatives of the values by the two loads.
    """
    _, p, q, _ = nodal(one)
    by_pressure, by_both = (
        problem.interface.work_of_imposed(p, 0 * q),
        problem.interface.work_of_imposed(p, q),
    )
    work = (i == 0) * other[:, 0] + by_both[..., 2] * other[:, 2]
    return np.asarray(work + by_pressure[..., j - 2] if j in (2, 3) else work)


def certificates(problem: ContactProblem, states: Sequence[InterfaceState]) -> dict[str, Array]:
    """Violations (m,) of law and equilibrium at the ends of increments, over the largest nodal
    force and its work.

    The force is at least a tenth of the mean one at the largest load: at the very first touch there
    is nothing but rounding.
    """
    values, loads = (
        np.stack([state.values for state in states]),
        np.array([state.loads for state in states]),
    )
    slip, pressure, shear, gap = nodal(values)
    force = np.maximum(pressure[1:].max(axis=1), 0.1 / pressure.shape[1])
    found = violations(gap[1:], pressure[1:], shear[1:], np.diff(slip, axis=0), problem.friction)
    carried = np.array(problem.interface.carried(pressure[1:].T, shear[1:].T))
    equilibrium = np.abs(carried - loads[1:, :2].T).max(axis=0)
    if problem.moment_given:
        moment = -problem.interface.work_of_imposed(pressure[1:], shear[1:])[:, 2]
        equilibrium = np.maximum(equilibrium, np.abs(moment - loads[1:, 4]))
    scaled = {
        name: found[name] / force for name in ("tension", "gap_pressure", "cone", "slip_sign")
    }
    return {"equilibrium": equilibrium / np.maximum(loads[1:, 0], 1e-300), **found, **scaled}
