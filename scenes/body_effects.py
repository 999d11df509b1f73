"""What finite bodies add to the compliance of half-planes, as numbers: the value that a linear
solve of the bodies makes and corrected theory takes. No mechanics.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Estimate(NamedTuple):
    """A number and its uncertainty."""

    value: float
    uncertainty: float = 0.0


ZERO = Estimate(0.0)


@dataclass(frozen=True)
class BodyEffects:
    """The relative problem of two bodies, less that of two half-planes of the same materials.

    With normal load P and tangential load Q per thickness, gap h(x), x along the surface from first
    contact, slip of the upper over the lower body, the bodies add::

        gap    += (N P + N_Q Q) x^2 / 2 + (alpha_P P + alpha_Q Q) x - c_n P
        slip   += -(T Q + T_P P) x^2 / 2 - (e_P P + e_Q Q) x + c_t Q

    to first and second order in half-width over height. Signs as in a scene: Q is positive along +x
    on the lower body, pressure positive in compression.

    Parameters
    ----------
    datum_length
        L, distance of the datum of the half-planes that the compliances are added to [length].
    normal_compliance, tangential_compliance
        c_n, c_t: approach per P, tangential displacement per Q [1 / stress].
    normal_curvature, tangential_curvature
        N, T: curvature of the gap per P, of the tangential displacement per Q
        [1 / (stress length^2)].
    normal_curvature_under_shear, tangential_curvature_under_pressure
        N_Q, T_P [1 / (stress length^2)]; zero for bodies with a mirror line at x = 0.
    tilt_under_pressure, tilt_under_shear
        alpha_P, alpha_Q: slope of the gap per load [1 / (stress length)].
    strain_under_pressure, strain_under_shear
        e_P, e_Q: difference of bulk strains, lower less upper, per load [1 / (stress length)].
    normal_fourth, tangential_fourth
        N_4, T_4: the coefficients of x^4 / 24 beside N and T, the size of the next order
        [1 / (stress length^4)].
    """

    datum_length: float
    normal_compliance: Estimate = ZERO
    tangential_compliance: Estimate = ZERO
    normal_curvature: Estimate = ZERO
    tangential_curvature: Estimate = ZERO
    normal_curvature_under_shear: Estimate = ZERO
    tangential_curvature_under_pressure: Estimate = ZERO
    tilt_under_pressure: Estimate = ZERO
    tilt_under_shear: Estimate = ZERO
    strain_under_pressure: Estimate = ZERO
    strain_under_shear: Estimate = ZERO
    normal_fourth: Estimate = ZERO
    tangential_fourth: Estimate = ZERO
