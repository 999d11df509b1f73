"""What displacements count from. Those of half-planes have no datum: theory counts U and the
normal approach from a place at an arbitrary distance, the finite elements of finite bodies from
their supports. The compliances c_t and c_n of the bodies lead from the one to the other:
U + c_t Q, approach + c_n P.
"""

from __future__ import annotations

from dataclasses import replace

from reports.comparison.cycles import Cycle
from reports.comparison.pairs import has_coupled_tractions, is_corrected
from scenes import BodyEffects, ContactSolution, InputError, read_only_copy


def effects_between(reference: ContactSolution, result: ContactSolution) -> BodyEffects | None:
    """The compliances c_t and c_n of the finite bodies of a scene, by which the displacements of
    half-plane theory are counted from the bodies' supports: U + c_t Q, approach + c_n P.

    With them theory and finite elements can be compared. None where they are not needed, since both
    solutions count their displacements from the same place. None too where they are not known:
    curved faces, coupled materials (Dundurs' beta is not 0), bulk stress.

    c_t: tangential displacement by the bodies per Q, c_n: approach by the bodies per P [1/stress].
    """
    scene = result.scene
    if lacks_datum(reference) == lacks_datum(result) or has_coupled_tractions(scene):
        return None
    import halfplane_fe

    try:
        return halfplane_fe.body_effects(scene)
    except InputError:
        return None


def lacks_datum(solution: ContactSolution) -> bool:
    """Whether the displacements of a solution are counted from no support: it is half-plane theory
    for a scene of finite bodies, without the compliances of these bodies.
    """
    is_plain_theory = solution.engine == "semi_analytic" and not is_corrected(solution)
    return is_plain_theory and not solution.scene.bodies.half_planes


def cycle_from_supports(cycle: Cycle, effects: BodyEffects) -> Cycle:
    """A cycle of half-plane theory, with tangential displacement and normal approach counted from
    the supports of the bodies: U + c_t Q and approach + c_n P, (k,) at the instants of the cycle.
    c_t and c_n are the compliances of the finite bodies in `effects` [1/stress].
    """
    displacement_of_bodies = effects.tangential_compliance.value * cycle.tangential_load
    approach_of_bodies = effects.normal_compliance.value * cycle.normal_load
    return replace(
        cycle,
        tangential_displacement=read_only_copy(
            cycle.tangential_displacement + displacement_of_bodies
        ),
        normal_approach=read_only_copy(cycle.normal_approach + approach_of_bodies),
    )
