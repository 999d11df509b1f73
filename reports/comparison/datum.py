"""What displacements count from. Those of half-planes have no datum: theory counts U and the
normal approach from a place at an arbitrary distance, the finite elements of finite bodies from
their supports. The compliances c_t and c_n of the bodies lead from the one to the other:
U + c_t Q, approach + c_n P.
"""

from __future__ import annotations

from dataclasses import replace

from reports.comparison.cycles import Cycle
from reports.comparison.pairs import coupled
from scenes import BodyEffects, ContactSolution, InputError, freeze


def effects_between(reference: ContactSolution, result: ContactSolution) -> BodyEffects | None:
    """What finite bodies add to the displacements of half-planes, (c_t Q, c_n P), where only one of
    two solutions counts its displacements from the bodies' supports.

    With it both can be compared. None where both count alike, and where it is not known: curved
    faces, coupled materials, bulk stress.
    """
    scene = result.scene
    if lacks_datum(reference) == lacks_datum(result) or coupled(scene):
        return None
    import halfplane_fe

    try:
        return halfplane_fe.body_effects(scene)
    except InputError:
        return None


def lacks_datum(solution: ContactSolution) -> bool:
    """Whether it is theory of half-planes in place of the finite bodies of its scene."""
    is_plain_theory = solution.engine == "semi_analytic" and "effects" not in solution.settings
    return is_plain_theory and not solution.scene.bodies.half_planes


def from_supports(cycle: Cycle, effects: BodyEffects) -> Cycle:
    """A cycle of half-planes with displacement and approach as the supports of the bodies see them:
    U + c_t Q and approach + c_n P.
    """
    of_shear = effects.tangential_compliance.value * cycle.tangential_load
    of_pressure = effects.normal_compliance.value * cycle.normal_load
    return replace(
        cycle,
        tangential_displacement=freeze(cycle.tangential_displacement + of_shear),
        normal_approach=freeze(cycle.normal_approach + of_pressure),
    )
