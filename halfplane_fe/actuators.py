"""Rigs: movements of actuators in the place of the loads P and Q, as loads of the contact problem.

Between an actuator and the contact is a compliance c, that of the rig's spring and of the bodies
beyond the datum of the condensed ones. A load that is a movement has its own row in the linear
systems (`systems`)::

    P, Q given              sum p = P,                 sum q = Q
    movements given         approach + c_n P = d,      U + c_t Q = u

so that P or Q is one more unknown of each increment. Where U is given, the bodies may slide on each
other as a whole: the contact still has an answer when no node sticks.

# notation: 1/E* = sum of (1 - nu^2)/E, L distance from the contact at which a half-plane counts as
#           unmoved
"""

from __future__ import annotations

import math

from halfplane_fe.systems import LOADS_ARE_GIVEN, Actuators
from scenes import HalfPlane, Scene


def actuators_of(scene: Scene, datum_length: float) -> Actuators:
    """Which loads of a scene are prescribed as movements of actuators, and the compliance between
    actuator and contact, dimensionless: times E*.

    It is the compliance of the rig's spring plus that of half-planes between two distances from the
    contact. One is `datum_length` [length], where the finite elements count displacement from. The
    other is where the actuator's movement counts from. Where loads are given, no movement is
    prescribed. A normal actuator is there only where the loads state an approach, not P.

    `scene` has the loads (`is_driven` where they are movements), the rig with the stiffnesses of
    its springs and the distance that movements count from, bodies and materials.
    """
    scene_load = scene.load
    if not scene_load.is_driven:
        return LOADS_ARE_GIVEN  # no actuator
    rig = scene.rig
    e_star = 1 / _sum_of_compliances(scene, half_planes_alone=False)  # contact modulus E*
    # `compliance_beyond`: of the half-planes of the scene, between both distances [1 / stress].
    # Where the rig states no distance, displacement counts from where it does in every answer.
    datum_length_of_movement = rig.datum_length or scene.profile.datum_length
    compliance_of_half_planes = (
        compliance_beyond(scene, datum_length_of_movement / datum_length) * e_star
    )
    # A rig without a stiffness is rigid.
    normal_compliance = compliance_of_half_planes + e_star / (rig.normal_stiffness or math.inf)
    tangential_compliance = compliance_of_half_planes + e_star / (
        rig.tangential_stiffness or math.inf
    )
    return Actuators(
        normal_compliance if scene_load.states_approach else None, tangential_compliance
    )


def compliance_beyond(scene: Scene, ratio: float) -> float:
    """Compliance of the half-planes of a scene between their datum and `ratio` times that distance
    from the contact [1 / stress]: (2/pi) (1 - nu^2)/E ln(ratio) each. The datum is where their
    surface counts as unmoved. Other bodies stand on supports, and add nothing.
    """
    return 2 / math.pi * _sum_of_compliances(scene, half_planes_alone=True) * math.log(ratio)


def _sum_of_compliances(scene: Scene, *, half_planes_alone: bool) -> float:
    """Sum of (1 - nu^2)/E of both bodies, or of the half-planes among them [1 / stress].

    # notation: E Young's modulus, nu Poisson's ratio of each body
    """
    bodies = (
        (scene.bodies.lower, scene.material.lower),
        (scene.bodies.upper, scene.material.upper),
    )
    return sum(
        (1 - material.poisson_ratio**2) / material.young_modulus
        for shape, material in bodies
        if isinstance(shape, HalfPlane) or not half_planes_alone
    )
