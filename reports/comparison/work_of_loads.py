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
from scenes import ContactSolution, Materials, read_only_copy
from scenes.array_types import Array


def bulk_strains_per_stress(materials: Materials) -> tuple[float, float]:
    """Bulk strain eps per bulk stress of the lower and of the upper body, 1/E' and −1/E', with
    E' = E/(1 − nu^2) [1/stress]. eps is the strain of the lower body minus that of the upper one.

    >>> steel = Materials.model_validate({"young_modulus": 210e3, "poisson_ratio": 0.3})
    >>> [round(1 / compliance) for compliance in bulk_strains_per_stress(steel)]
    [230769, -230769]
    """
    lower_material = materials.lower
    upper_material = materials.upper
    lower_compliance = (1 - lower_material.poisson_ratio**2) / lower_material.young_modulus
    upper_compliance = (1 - upper_material.poisson_ratio**2) / upper_material.young_modulus
    return lower_compliance, -upper_compliance


def bulk_strain(source: ContactSolution | Cycle, materials: Materials) -> Array:
    """eps = sigma_lower/E'_lower − sigma_upper/E'_upper at every instant of a solution or a cycle,
    (n_instants,); 0 without bulk stress.
    """
    strain = np.zeros(len(source.time))
    stresses = (source.bulk_stress_lower, source.bulk_stress_upper)
    for compliance, stress in zip(bulk_strains_per_stress(materials), stresses, strict=True):
        if stress is not None:
            strain = strain + compliance * stress
    return strain


def loop_work(cycle: Cycle) -> float:
    """Closed integral of Q dU by the trapezoidal rule over the instants of a cycle [energy /
    thickness]. With half-planes under P and Q alone it is the dissipation W.
    """
    return float(np.trapezoid(cycle.tangential_load, cycle.tangential_displacement))


def bulk_work(source: ContactSolution | Cycle, materials: Materials) -> float:
    """Work of the bulk stress over the instants of a solution or a cycle: −(closed integral of
    m_q d(eps)) by the trapezoidal rule [energy / thickness]; 0 without bulk stress.

    m_q is the moment of the shear about x = 0, where U is read; eps is the bulk strain of the lower
    body minus that of the upper one. This work and the closed integral of Q dU add up to the
    dissipation.
    """
    if source.shear_moment is None:
        return 0.0
    return -float(np.trapezoid(source.shear_moment, bulk_strain(source, materials)))


def normal_work(solution: ContactSolution) -> float | None:
    """Work of the normal load P and the moment M in the last cycle: closed integral of
    P dV − M d(tilt), V the normal approach, by the trapezoidal rule [energy / thickness].

    This work, the closed integral of Q dU and the work of the bulk stress add up to the
    dissipation.

    None where it is always 0: where P and the tilt are constant, and for half-planes of like
    materials, whose V and M depend on P and the tilt only. None too where V is not known, as in a
    solution that is not of the project's finite elements, or holds no closed cycle (`loop_work` is
    NaN).
    """
    indices = solution.last_cycle  # of the instants
    has_constant_tilt = solution.tilt is None or np.ptp(solution.tilt[indices]) == 0
    has_constant_loads = np.ptp(solution.normal_load[indices]) == 0 and has_constant_tilt
    has_approach = solution.engine == "halfplane_fe" and not np.isnan(solution.loop_work)
    if has_constant_loads or are_half_planes(solution.scene) or not has_approach:
        return None
    work = float(np.trapezoid(solution.normal_load[indices], solution.normal_approach[indices]))
    if solution.tilt is not None and solution.moment is not None:
        work += float(np.trapezoid(-solution.moment[indices], solution.tilt[indices]))
    return work


def solution_on_straight_steps(solution: ContactSolution) -> ContactSolution:
    """The solution with the dissipation that it would have if the load path were straight between
    its instants: the work that finite elements add for the curve of the path is subtracted.
    """
    # (n_instants,) work added for the curve in the increment that ends at each instant; None where
    # nothing was added
    curve_work = solution.record.energy.get("curve")
    if curve_work is None or not solution.dissipation > 0:
        return solution
    # without the first instant, which ends an increment of the cycle before
    curve_work_of_cycle = float(curve_work[solution.last_cycle[1:]].sum())
    share_of_straight_lines = 1 - curve_work_of_cycle / solution.dissipation
    return replace(
        solution,
        dissipation=solution.dissipation * share_of_straight_lines,
        dissipation_density=read_only_copy(solution.dissipation_density * share_of_straight_lines),
    )
