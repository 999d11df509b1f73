"""Energy balance and Coulomb certificates of one increment: checks that need no reference. Scaled, like `contact`.

With loads, forces and displacements taken at the middle of the increment the balance

    P d(delta) + Q dU = d(elastic energy) + sum q ds - sum p dg

is an identity of the discrete problem: a check of the algebra. What the increment itself costs shows in the three ways to write the
friction work: at its middle (f p ds, second order), trapezoidal (q ds), at its end (first order). The work of the loads at its end,
P d(delta) + Q dU with the new P and Q, has the normal part of that error in it: on the interface there is none, because increments
land on each touch and release, so that p dg is zero in each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.law import slip_sign, violations

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class IncrementEnergy:
    """Energies of one increment (over P^2/E*), and the dissipation of each node (n,).

    Attributes
    ----------
    dissipation : (n,) f p |ds| of each sliding node, p being the mean of the increment
    external : work of P and Q
    external_end_of_step : the same with the loads at the end of the increment
    elastic : change of elastic energy, that of the penalty layer included
    layer : change of the energy of the penalty layer
    interface : trapezoidal work of shear less that of pressure
    end_of_step : the same with the forces at the end of the increment
    step_error : estimate of the error of the increment's dissipation: friction work at its middle less trapezoidal, node by node.
        They differ at the nodes that start to slide in it.
    """

    dissipation: Array
    external: float
    external_end_of_step: float
    elastic: float
    layer: float
    interface: float
    end_of_step: float
    step_error: float


def elastic_energy(problem: ContactProblem, state: InterfaceState) -> float:
    """Elastic energy of both bodies and of the layer between them."""
    p, q = state.pressure, state.shear
    gap_moved, slip_moved = problem.interface.moved(state.approach, state.shift)
    gap_part = state.gap - problem.height - gap_moved  # N p - K^T q
    slip_part = slip_moved - state.slip  # T q - K p
    return float(p @ gap_part + q @ slip_part) / 2


def layer_energy(problem: ContactProblem, state: InterfaceState) -> float:
    """Elastic energy of the layer of the penalty method, pressed and sheared; 0 without one."""
    layer = problem.layer
    return float(layer.normal @ state.pressure**2 + layer.tangential @ state.shear**2) / 2


def increment_energy(problem: ContactProblem, before: InterfaceState, after: InterfaceState) -> IncrementEnergy:
    """Energies between two states that follow each other."""
    slip, gap = after.slip - before.slip, after.gap - before.gap
    approach, shift = after.approach - before.approach, after.shift - before.shift
    mean_p, mean_q = (before.pressure + after.pressure) / 2, (before.shear + after.shear) / 2
    external = (before.normal_load + after.normal_load) / 2 * approach + (
        before.tangential_load + after.tangential_load
    ) / 2 * shift
    dissipation = problem.friction * mean_p * np.maximum(slip_sign(after.state) * slip, 0.0)
    trapezoidal = np.where(slip_sign(after.state) != 0, mean_q * slip, 0.0)
    return IncrementEnergy(
        dissipation=dissipation,
        external=external,
        external_end_of_step=after.normal_load * approach + after.tangential_load * shift,
        elastic=elastic_energy(problem, after) - elastic_energy(problem, before),
        layer=layer_energy(problem, after) - layer_energy(problem, before),
        interface=float(mean_q @ slip - mean_p @ gap),
        end_of_step=float(after.shear @ slip - after.pressure @ gap),
        step_error=float(np.abs(dissipation - trapezoidal).sum()),
    )


def certificates(problem: ContactProblem, before: InterfaceState, after: InterfaceState) -> dict[str, float]:
    """Violations of law and equilibrium at the end of an increment, over the largest nodal force and its work.

    The force is at least a tenth of the mean one at the largest load: at the very first touch there is nothing but rounding.
    """
    force = max(float(after.pressure.max(initial=0.0)), 0.1 / len(after.pressure))
    found = violations(after.gap, after.pressure, after.shear, after.slip - before.slip, problem.friction)
    normal_load, tangential_load = problem.interface.carried(after.pressure, after.shear)
    equilibrium = max(abs(normal_load - after.normal_load), abs(tangential_load - after.tangential_load))
    return {
        "equilibrium": equilibrium / max(after.normal_load, 1e-300),
        "tension": found["tension"] / force,
        "penetration": found["penetration"],
        "gap_pressure": found["gap_pressure"] / force,
        "cone": found["cone"] / force,
        "slip_sign": found["slip_sign"] / force,
        "creep": found["creep"],
    }
