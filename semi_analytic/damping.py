"""What dynamics takes from a contact: the loop of Q over the tangential displacement as a stiffness
and a damping ratio.

# notation: A = 2/E*, L datum length, a and c contact and stick half-width, W dissipation of a
#           cycle, Q1 and U1 half the ranges of Q and of the tangential displacement U

While P rests, a change dQ that lets the slip go on raises the whole memory above the stick edge
load by dQ, and a reversal raises it at the edge of the contact: dU/dQ = (A/pi) ln(2 L/c), c being a
in full stick and right after a reversal.

L is arbitrary: U of half-planes, and with it stiffness and damping ratio, are those of an actuator
only where a datum length is stated, or what finite bodies add: U + c_t Q.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scenes import BodyEffects, ContactSolution, InputError, read_only_copy
from scenes.array_types import Array
from scenes.solution import require_solution
from semi_analytic.elasticity import composite_modulus


@dataclass(frozen=True, eq=False)
class Hysteresis:
    """The loop of the tangential load Q over the displacement U of the last cycle, per unit
    thickness.

    Attributes
    ----------
    dissipation
        W [energy per thickness]
    force_amplitude, shift_amplitude
        Q1, half the range of Q [force per thickness]; U1, half the range of the tangential
        displacement U [length]
    secant_stiffness
        Q1/U1 [stress]
    damping_ratio
        of the linear oscillator that dissipates W at the same Q1 and U1, W/(2 pi Q1 U1)
    """

    dissipation: float
    force_amplitude: float
    shift_amplitude: float
    secant_stiffness: float
    damping_ratio: float


def hysteresis(
    solution: ContactSolution,
    *,
    datum_length: float | None = None,
    effects: BodyEffects | None = None,
) -> Hysteresis:
    """Secant stiffness, damping ratio and dissipation of the hysteresis loop in the last cycle of a
    solution: tangential load Q, per unit thickness, over tangential displacement U.

    Parameters
    ----------
    solution
        of finite bodies, which counts U from their supports; or of half-planes, which needs either
        `datum_length` or `effects`. It holds the tangential displacement and the dissipation
    datum_length
        L, distance from the load at which the surface of a half-plane is taken not to move
        [length]; `scene.profile.datum_length` is that of the solution
    effects
        what finite bodies add, `halfplane_fe.body_effects(scene)`; of it the tangential compliance
        c_t is taken, with its datum length

    Raises
    ------
    InputError
        For half-planes without a datum length or effects, or with both; for finite bodies with
        either. For a datum length that is not finite and above 0. For a solution with bulk stress,
        without the fields, or without a whole cycle, and where Q does not move.

    Examples
    --------
    >>> from scenes import load_scene
    >>> from semi_analytic import solve
    >>> scene = load_scene("cattaneo-mindlin")
    >>> loop = hysteresis(solve(scene, x=[0.0]), datum_length=scene.profile.datum_length)
    >>> round(loop.damping_ratio, 5)
    0.00607
    """
    require_solution(solution, "hysteresis")
    rows_of_cycle = solution.last_cycle  # indices of its instants
    if any(
        np.any(stress)
        for stress in (solution.bulk_stress_lower, solution.bulk_stress_upper)
        if stress is not None
    ):
        raise InputError(
            "hysteresis: with bulk stress the loop of Q over U is not the dissipation: `solve`"
            " gives both"
        )
    if len(rows_of_cycle) < 3:
        raise InputError("hysteresis: the times of the solution hold no whole cycle")

    # Added to U per Q: change of the datum length, and c_t of finite bodies.
    compliance_to_datum = added_compliance(solution, "hysteresis", datum_length, effects)
    displacement = solution.tangential_displacement + compliance_to_datum * solution.tangential_load
    force_amplitude = np.ptp(solution.tangential_load[rows_of_cycle]) / 2
    displacement_amplitude = np.ptp(displacement[rows_of_cycle]) / 2
    if not np.all(np.isfinite(solution.tangential_displacement)) or not math.isfinite(
        solution.dissipation
    ):
        raise InputError("hysteresis: ask for the fields tangential_displacement and dissipation")
    if not force_amplitude > 0:
        raise InputError(
            "hysteresis: the tangential load does not move in the last cycle: there is no loop"
        )
    return Hysteresis(
        dissipation=solution.dissipation,
        force_amplitude=float(force_amplitude),
        shift_amplitude=float(displacement_amplitude),
        secant_stiffness=float(force_amplitude / displacement_amplitude),
        damping_ratio=float(
            solution.dissipation / (2 * math.pi * force_amplitude * displacement_amplitude)
        ),
    )


def added_compliance(
    solution: ContactSolution,
    caller: str,
    datum_length: float | None,
    effects: BodyEffects | None,
) -> float:
    """Difference of the tangential compliance dU/dQ of a contact with a given reference of the
    tangential displacement U to that of a solution [1/stress].

    U of half-planes needs a datum length L, a distance from the load at which the surface does not
    move. The difference is c + (A/pi) ln(L/L_solution), A = 2/E*: c = c_t and L are those of
    `effects`, or c = 0 and L = `datum_length`. It is 0 for finite bodies, whose U counts from their
    supports.

    Parameters
    ----------
    solution
        solution of half-planes or of finite bodies
    caller
        name of the function that begins the messages
    datum_length
        L [length]; None if `effects` are given
    effects
        datum length L and tangential compliance c_t of finite bodies; None if L is given

    Raises
    ------
    InputError
        For half-planes without either, for both at once, and for either beside finite bodies; for
        a datum length that is not a finite number above 0.
    """
    # By theory without the effects of finite bodies, whatever bodies the scene has.
    is_half_plane_theory = solution.engine == "semi_analytic" and "effects" not in solution.settings
    if not is_half_plane_theory and not solution.scene.bodies.half_planes:
        if datum_length is not None or effects is not None:
            raise InputError(
                f"{caller}: U of finite bodies counts from their supports: leave datum_length and"
                " effects out"
            )
        return 0.0
    if (datum_length is None) == (effects is None):
        raise InputError(
            f"{caller}: U of half-planes has no datum: give datum_length, a length, or effects of"
            " finite bodies (halfplane_fe.body_effects), one of the two"
        )
    datum_of_solution = solution.scene.profile.datum_length
    if effects is not None:
        stated_length = effects.datum_length
        compliance_of_bodies = effects.tangential_compliance.value
    else:
        stated_length = datum_length or 0.0
        compliance_of_bodies = 0.0
    if not 0 < stated_length < math.inf:
        raise InputError(f"{caller}: datum_length = {stated_length} is refused: a length above 0")
    # A/pi of half-planes.
    unit_compliance = 2 / (math.pi * composite_modulus(solution.scene.material))
    return compliance_of_bodies + unit_compliance * math.log(stated_length / datum_of_solution)


def compliance(
    solution: ContactSolution,
    *,
    datum_length: float | None = None,
    effects: BodyEffects | None = None,
) -> tuple[Array, Array]:
    """Tangential compliances dU/dQ of a contact of half-planes at constant P, (n,) each at the n
    instants of a solution [1/stress]: while slip continues, infinite if nothing sticks; and right
    after a reversal of Q.

    It is (A/pi) ln(2 L/c), A = 2/E*, with the stick half-width c, or with the contact half-width
    after a reversal. U, the tangential displacement, needs a reference: either `datum_length` L,
    the distance from the load at which the surface does not move [length], or the `effects` of
    finite bodies, whose tangential compliance c_t is added. InputError for both or neither, for
    solutions with bulk stress or tilt, and for those of finite bodies.

    >>> from scenes import load_scene
    >>> from semi_analytic import solve
    >>> solution = solve(load_scene("cattaneo-mindlin"), x=[0.0], time=[1.0, 2.0])
    >>> in_slip, after_reversal = compliance(solution, datum_length=1000.0)
    >>> (
    ...     bool(in_slip[0] == after_reversal[0] == after_reversal[1]),
    ...     round(float(in_slip[1] / after_reversal[1]), 6),
    ... )  # ln(2000/0.632)/ln(2000)
    (True, 1.060275)
    """
    require_solution(solution, "compliance")
    if solution.tilt is not None:
        raise InputError("compliance: it is for symmetric profiles without bulk stress and tilt")
    is_half_plane_theory = solution.engine == "semi_analytic" and "effects" not in solution.settings
    if not is_half_plane_theory and not solution.scene.bodies.half_planes:
        raise InputError("compliance: the formula is that of half-planes; solve by theory")
    # The logarithms below take the datum length of the solution. Added to dU/dQ: the change to the
    # datum length L that was given, and c_t of finite bodies.
    compliance_to_datum = added_compliance(solution, "compliance", datum_length, effects)
    unit_compliance = 2 / (math.pi * composite_modulus(solution.scene.material))
    twice_datum_of_solution = 2 * solution.scene.profile.datum_length
    # A half-width of 0 gives an infinite compliance.
    with np.errstate(divide="ignore"):
        compliance_in_slip = (
            unit_compliance
            * np.log(twice_datum_of_solution / np.nan_to_num(solution.stick_half_width))
            + compliance_to_datum
        )
        compliance_after_reversal = unit_compliance * np.log(
            twice_datum_of_solution / np.nan_to_num(solution.contact_half_width)
        )
        compliance_after_reversal = compliance_after_reversal + compliance_to_datum
    return read_only_copy(compliance_in_slip), read_only_copy(compliance_after_reversal)
