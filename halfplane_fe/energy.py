"""Energy balance and Coulomb certificates of one increment: checks that need no reference. Scaled, like `contact`.

With loads, forces and displacements taken at the middle of the increment the balance

    P d(delta) + Q dU + sum F_i de_i = d(elastic energy) + sum q ds - sum p dg,   F = S q - G p

is an identity of the discrete problem: a check of the algebra. Here e are the bulk stresses and the tilt, and F de is -m_q d(eps)
- M d(alpha) of half-planes, see `interface`. What the increment itself costs shows in the three ways to write the friction work:
at its middle (f p ds), trapezoidal (q ds), at its end (first order). The work of the loads at its end,
P d(delta) + Q dU with the new P and Q, has the normal part of that error in it: on the interface there is none, because increments
land on each touch and release, so that p dg is zero in each.

The loads follow a curve where the increment solves its chord. While the states of the nodes stay, p and s are linear in P, Q and
the other loads, and the friction work along the curve is that along the chord plus, node by node and for each pair of loads,

    f (p_Q s_P - p_P s_Q) (int Q dP of the curve - of the chord),

subscripts being derivatives by the loads. The sum over the nodes is the work of the loads, (U_P - delta_Q) times that area.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import ContactProblem, InterfaceState, Rate
from halfplane_fe.law import slip_sign, violations

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class IncrementEnergy:
    """Energies of one increment (over P^2/E*), and the dissipation of each node (n,).

    Attributes
    ----------
    dissipation : (n,) f p |ds| of each sliding node, p being the mean of the increment, and what the curve of the loads adds
    loop : integral of Q dU along the curve of the loads, and of q in the slip by bulk stress (-m_q d(eps) of half-planes)
    external : work of P, Q, bulk stresses and tilt along the chord
    curve : what the curve of the loads adds to it, all of it friction work
    external_end_of_step : the same with the loads at the end of the increment
    elastic : change of elastic energy, that of the penalty layer included
    layer : change of the energy of the penalty layer
    interface : trapezoidal work of shear less that of pressure
    end_of_step : the same with the forces at the end of the increment
    step_error : bound of the error of the dissipation: f |dp| |ds| / 2 of the nodes that start to slide in it
    """

    dissipation: Array
    loop: float
    external: float
    external_end_of_step: float
    curve: float
    elastic: float
    layer: float
    interface: float
    end_of_step: float
    step_error: float


def elastic_energy(problem: ContactProblem, state: InterfaceState) -> float:
    """Elastic energy of both bodies and of the layer between them."""
    p, q = state.pressure, state.shear
    gap_moved, slip_moved = problem.interface.moved(state.approach, state.shift)
    gap_imposed, slip_imposed = problem.offsets(state.imposed)
    gap_part = state.gap - problem.height - gap_moved - gap_imposed  # N p - K^T q
    slip_part = slip_moved + slip_imposed - state.slip  # T q - K p
    return float(p @ gap_part + q @ slip_part) / 2


def layer_energy(problem: ContactProblem, state: InterfaceState) -> float:
    """Elastic energy of the layer of the penalty method, pressed and sheared; 0 without one."""
    layer = problem.layer
    return float(layer.normal @ state.pressure**2 + layer.tangential @ state.shear**2) / 2


def increment_energy(
    problem: ContactProblem, before: InterfaceState, after: InterfaceState, enclosed: Array | None
) -> IncrementEnergy:
    """Energies between two states that follow each other; `enclosed`: see `path`, over the units of the loads."""
    slip, gap = after.slip - before.slip, after.gap - before.gap
    approach, shift = after.approach - before.approach, after.shift - before.shift
    mean_p, mean_q = (before.pressure + after.pressure) / 2, (before.shear + after.shear) / 2
    mean_load = (before.tangential_load + after.tangential_load) / 2
    imposed = after.imposed - before.imposed
    faces = problem.interface
    work_of_imposed = float(faces.work_of_imposed(mean_p, mean_q) @ imposed)
    sign = slip_sign(after.state)
    dissipation = problem.friction * mean_p * np.maximum(sign * slip, 0.0)
    # The shear of a node that starts to slide has a kink in the increment, and the work of Q with it.
    loop = mean_load * shift + float(np.sum(dissipation - np.where(sign != 0, mean_q * slip, 0.0)))
    loop += float(faces.work_of_imposed(0 * mean_p, mean_q)[:2] @ imposed[:2])
    curve, starting = np.zeros_like(slip), sign != slip_sign(before.state)  # of what starts, the curve is left out
    if enclosed is not None and not starting[sign != 0].all():
        pairs = np.argwhere(np.tril(enclosed)).tolist()
        rates = problem.rates(before.state, len(after.loads), {number for pair in pairs for number in pair})
        of_normal = 0.0  # of the loads that the friction work along the curve leaves
        for i, j in pairs:
            one, other, area = rates[i], rates[j], float(enclosed[i, j])
            exchanged = one.pressure * other.slip - other.pressure * one.slip
            curve = curve + problem.friction * np.where(starting, 0.0, sign) * exchanged * area
            of_normal += (_normal_work(problem, rates, i, j) - _normal_work(problem, rates, j, i)) * area
        curve = np.maximum(curve, -dissipation)  # friction only takes
        loop += float(curve.sum()) - of_normal
    changed = np.abs((after.pressure - before.pressure) * slip)[starting & (sign != 0)]
    return IncrementEnergy(
        dissipation=dissipation + curve,
        loop=loop,
        external=(before.normal_load + after.normal_load) / 2 * approach + mean_load * shift + work_of_imposed,
        external_end_of_step=after.normal_load * approach
        + after.tangential_load * shift
        + float(faces.work_of_imposed(after.pressure, after.shear) @ imposed),
        curve=float(curve.sum()),
        elastic=elastic_energy(problem, after) - elastic_energy(problem, before),
        layer=layer_energy(problem, after) - layer_energy(problem, before),
        interface=float(mean_q @ slip - mean_p @ gap),
        end_of_step=float(after.shear @ slip - after.pressure @ gap),
        step_error=problem.friction * float(changed.sum()) / 2,
    )


def _normal_work(problem: ContactProblem, rates: Mapping[int, Rate], i: int, j: int) -> float:
    """Work per unit of load i times change of load j, but for that of shear: of P in the approach, of p in bulk stress and tilt."""
    one, other = rates[i], rates[j]
    change = np.array([float(j == 2), float(j == 3), other.tilt])
    by_forces = problem.interface.work_of_imposed(one.pressure, one.shear)
    by_forces[:2] -= problem.interface.work_of_imposed(0 * one.pressure, one.shear)[:2]
    return float(i == 0) * other.approach + float(by_forces @ change)


def certificates(problem: ContactProblem, before: InterfaceState, after: InterfaceState) -> dict[str, float]:
    """Violations of law and equilibrium at the end of an increment, over the largest nodal force and its work.

    The force is at least a tenth of the mean one at the largest load: at the very first touch there is nothing but rounding.
    """
    force = max(float(after.pressure.max(initial=0.0)), 0.1 / len(after.pressure))
    found = violations(after.gap, after.pressure, after.shear, after.slip - before.slip, problem.friction)
    normal_load, tangential_load = problem.interface.carried(after.pressure, after.shear)
    equilibrium = max(abs(normal_load - after.normal_load), abs(tangential_load - after.tangential_load))
    if problem.moment_given:
        moment = -float(problem.interface.work_of_imposed(after.pressure, after.shear)[2])
        equilibrium = max(equilibrium, abs(moment - after.loads[4]))
    return {
        "equilibrium": equilibrium / max(after.normal_load, 1e-300),
        "tension": found["tension"] / force,
        "penetration": found["penetration"],
        "gap_pressure": found["gap_pressure"] / force,
        "cone": found["cone"] / force,
        "slip_sign": found["slip_sign"] / force,
        "creep": found["creep"],
    }
