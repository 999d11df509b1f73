"""What dynamics takes from a contact: the loop of Q over the tangential displacement as a stiffness
and a damping ratio.

# notation: A = 2/E*, L datum length, a and c contact and stick half-width, W dissipation of a
#           cycle, Q1 and U1 half the ranges of Q and of the tangential displacement U

While P rests, a change dQ that lets the slip go on raises the whole memory above the front by dQ,
and a reversal raises it at the edge of the contact: dU/dQ = (A/pi) ln(2 L/c), c being a in full
stick and right after a reversal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scenes import ContactSolution, InputError, freeze
from scenes.array_types import Array
from semi_analytic.elasticity import composite_modulus


@dataclass(frozen=True, eq=False)
class Hysteresis:
    """The loop of the last cycle, per unit thickness.

    Attributes
    ----------
    dissipation
        W [energy per thickness]
    force_amplitude, shift_amplitude
        Q1 [force per thickness], U1 [length]
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


def hysteresis(solution: ContactSolution) -> Hysteresis:
    """Stiffness and damping of the last cycle of a solution that holds the tangential displacement
    and the dissipation.

    Raises
    ------
    InputError
        Where the solution was not asked for them, holds no whole cycle, or where Q does not move.

    Examples
    --------
    >>> from scenes import load_scene
    >>> from semi_analytic import solve
    >>> loop = hysteresis(solve(load_scene("cattaneo-mindlin"), x=[0.0]))
    >>> round(loop.damping_ratio, 5)
    0.00607
    """
    cycle = solution.last_cycle
    if any(
        np.any(stress)
        for stress in (solution.bulk_stress_lower, solution.bulk_stress_upper)
        if stress is not None
    ):
        raise InputError(
            "hysteresis: with bulk stress the loop of Q over U is not the dissipation: `solve`"
            " gives both"
        )
    if len(cycle) < 3:
        raise InputError("hysteresis: the times of the solution hold no whole cycle")
    force, shift = (
        np.ptp(values[cycle]) / 2
        for values in (solution.tangential_load, solution.tangential_displacement)
    )
    if not np.all(np.isfinite(solution.tangential_displacement)) or not math.isfinite(
        solution.dissipation
    ):
        raise InputError("hysteresis: ask for the fields tangential_displacement and dissipation")
    if not force > 0:
        raise InputError(
            "hysteresis: the tangential load does not move in the last cycle: there is no loop"
        )
    return Hysteresis(
        dissipation=solution.dissipation,
        force_amplitude=float(force),
        shift_amplitude=float(shift),
        secant_stiffness=float(force / shift),
        damping_ratio=float(solution.dissipation / (2 * math.pi * force * shift)),
    )


def compliance(solution: ContactSolution) -> tuple[Array, Array]:
    """dU/dQ at constant P, (n_steps,) [1/stress]: while slip goes on (infinite where nothing
    sticks), right after a reversal.

    InputError for solutions with bulk stress or tilt.

    >>> from scenes import load_scene
    >>> from semi_analytic import solve
    >>> tangent, stick = compliance(solve(load_scene("cattaneo-mindlin"), x=[0.0], time=[1.0, 2.0]))
    >>> (
    ...     bool(tangent[0] == stick[0] == stick[1]),
    ...     round(float(tangent[1] / stick[1]), 6),
    ... )  # ln(2000/0.632)/ln(2000)
    (True, 1.060275)
    """
    if solution.tilt is not None:
        raise InputError("compliance: it is for symmetric profiles without bulk stress and tilt")
    factor = 2 / (math.pi * composite_modulus(solution.scene.material))
    datum_width = 2 * solution.scene.profile.datum_length
    with np.errstate(divide="ignore"):
        in_slip = factor * np.log(datum_width / np.nan_to_num(solution.stick_half_width))
        after_reversal = factor * np.log(datum_width / np.nan_to_num(solution.contact_half_width))
    return freeze(in_slip), freeze(after_reversal)
