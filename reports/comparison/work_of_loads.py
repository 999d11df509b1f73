"""Work of the loads over the last cycle: closed integrals of Q dU, of the bulk term, of P dV.

With half-planes under P and Q alone the first is the dissipation. Bulk stress adds a term, and
bodies of finite size or a tilt another one.

# notation: eps bulk strain, m_q moment of the shear about x = 0, V normal approach, M moment
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reports.comparison.cycles import Cycle
from reports.comparison.pairs import are_half_planes
from scenes import ContactSolution, Materials, freeze
from scenes.array_types import Array


def bulk_strains(materials: Materials) -> tuple[float, float]:
    """Strain eps per bulk stress in the lower and in the upper body: 1/E' and -1/E', E' = E/(1 -
    nu^2) [1/stress].

    >>> steel = Materials.model_validate({"young_modulus": 210e3, "poisson_ratio": 0.3})
    >>> [round(1 / compliance) for compliance in bulk_strains(steel)]
    [230769, -230769]
    """
    lower_material = materials.lower
    upper_material = materials.upper
    lower_compliance = (1 - lower_material.poisson_ratio**2) / lower_material.young_modulus
    upper_compliance = (1 - upper_material.poisson_ratio**2) / upper_material.young_modulus
    return lower_compliance, -upper_compliance


def bulk_strain(of: ContactSolution | Cycle, materials: Materials) -> Array:
    """eps = sigma_lower/E'_lower - sigma_upper/E'_upper at every instant, (n_steps,); 0 without
    bulk stress.
    """
    strain = np.zeros(len(of.time))
    stresses = (of.bulk_stress_lower, of.bulk_stress_upper)
    for compliance, stress in zip(bulk_strains(materials), stresses, strict=True):
        if stress is not None:
            strain = strain + compliance * stress
    return strain


def loop_work(cycle: Cycle) -> float:
    """Closed integral of Q dU by the trapezoidal rule over the instants [energy / thickness]: a
    second way to W.
    """
    return float(np.trapezoid(cycle.tangential_load, cycle.tangential_displacement))


def bulk_work(of: ContactSolution | Cycle, materials: Materials) -> float:
    """-closed integral of m_q d(eps) by the trapezoidal rule over the instants [energy /
    thickness]: what bulk stress puts in.

    m_q is the moment of the shear about x = 0, where U is read: this and the closed integral of Q
    dU add up to the dissipation, which neither is alone. 0 without bulk stress.
    """
    if of.shear_moment is None:
        return 0.0
    return -float(np.trapezoid(of.shear_moment, bulk_strain(of, materials)))


def normal_work(solution: ContactSolution) -> float | None:
    """Work of the normal load and the moment in the last cycle: closed integral of P dV - M
    d(tilt), V the normal approach, by the trapezoidal rule [energy / thickness].

    With Q dU and the bulk term it adds up to the dissipation. None where it is 0 by nature (P and
    tilt constant; half-planes of like materials, where V and M hang on P and the tilt only) and
    where the solution is not of our finite elements, which alone know V.
    """
    steps = solution.last_cycle
    tilt_is_constant = solution.tilt is None or np.ptp(solution.tilt[steps]) == 0
    loads_are_constant = np.ptp(solution.normal_load[steps]) == 0 and tilt_is_constant
    approach_is_known = solution.engine == "halfplane_fe" and not np.isnan(solution.loop_work)
    if loads_are_constant or are_half_planes(solution.scene) or not approach_is_known:
        return None
    work = float(np.trapezoid(solution.normal_load[steps], solution.normal_approach[steps]))
    if solution.tilt is not None and solution.moment is not None:
        work += float(np.trapezoid(-solution.moment[steps], solution.tilt[steps]))
    return work


def on_straight_steps(solution: ContactSolution) -> ContactSolution:
    """The solution with its dissipation as if the path were straight between its instants. Finite
    elements add the work that a curved path makes; it is taken off.
    """
    work_by_curve = solution.record.energy.get("curve")
    if work_by_curve is None or not solution.dissipation > 0:
        return solution
    work_of_curve = float(work_by_curve[solution.last_cycle[1:]].sum())
    share_of_straight_lines = 1 - work_of_curve / solution.dissipation
    return replace(
        solution,
        dissipation=solution.dissipation * share_of_straight_lines,
        dissipation_density=freeze(solution.dissipation_density * share_of_straight_lines),
    )
