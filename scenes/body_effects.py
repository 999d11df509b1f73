"""What finite bodies add to the compliance of half-planes, as numbers: the value that a linear
solve of the bodies makes (`halfplane_fe.body_effects`) and corrected theory takes. No mechanics.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Estimate(NamedTuple):
    """A number and its uncertainty."""

    value: float
    uncertainty: float = 0.0


ZERO_ESTIMATE = Estimate(0.0)


@dataclass(frozen=True)
class BodyEffects:
    """What two finite bodies add to the relative problem of two half-planes of the same materials.

    P and Q are loads per thickness, x counts along the surface from first contact. For a given
    normal approach and tangential displacement U of the upper body's base, its direction kept, the
    bodies add::

        gap(x)  += c_n P + (alpha_P P + alpha_Q Q) x + (N P + N_Q Q) x^2 / 2
        slip(x) -= c_t Q + (e_P P + e_Q Q) x + (T Q + T_P P) x^2 / 2

    to first and second order in half-width over height, so that the approach is c_n P and U is c_t
    Q larger. Signs as in a scene: Q is positive along +x on the lower body, slip is that of the
    upper over the lower body, pressure is positive in compression. Of two equal bodies alpha_Q and
    e_P vanish, of bodies with a mirror line at x = 0 alpha_P, e_Q, N_Q and T_P. Half-planes add
    nothing.

    With k_tn(x, s) the displacement along x at x by P at s, k_nt that outwards by Q, each in its
    body's own frame (y outward), e the slope of k_tn, a that of k_nt at x = s = 0, l lower and u
    upper: e_P = e_l - e_u, alpha_Q = a_u - a_l; N, T, c_n and c_t are sums over both bodies.

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
        N_Q, T_P [1 / (stress length^2)].
    tilt_under_pressure, tilt_under_shear
        alpha_P, alpha_Q: slope of the gap per load [1 / (stress length)].
    strain_under_pressure, strain_under_shear
        e_P, e_Q: strain of the lower face minus that of the upper one, per load
        [1 / (stress length)].
    normal_fourth, tangential_fourth
        N_4, T_4: the next order, coefficients of (x^4 + s^4) / 24 of the kernels beside N and T, s
        the place of a force [1 / (stress length^4)].
    normal_mixed, tangential_mixed
        N_22, T_22: those of x^2 s^2 [1 / (stress length^4)].
    dundurs_beta
        beta of the two materials, the upper body being the first. The odd numbers have effects of
        first order where it is not 0, which the formulas above do not say.
    unknowns, factorisations
        Degrees of freedom of all linear systems that were solved, and how many these were.
    """

    datum_length: float
    normal_compliance: Estimate = ZERO_ESTIMATE
    tangential_compliance: Estimate = ZERO_ESTIMATE
    normal_curvature: Estimate = ZERO_ESTIMATE
    tangential_curvature: Estimate = ZERO_ESTIMATE
    normal_curvature_under_shear: Estimate = ZERO_ESTIMATE
    tangential_curvature_under_pressure: Estimate = ZERO_ESTIMATE
    tilt_under_pressure: Estimate = ZERO_ESTIMATE
    tilt_under_shear: Estimate = ZERO_ESTIMATE
    strain_under_pressure: Estimate = ZERO_ESTIMATE
    strain_under_shear: Estimate = ZERO_ESTIMATE
    normal_fourth: Estimate = ZERO_ESTIMATE
    tangential_fourth: Estimate = ZERO_ESTIMATE
    normal_mixed: Estimate = ZERO_ESTIMATE
    tangential_mixed: Estimate = ZERO_ESTIMATE
    dundurs_beta: float = 0.0
    unknowns: int = 0
    factorisations: int = 0

    def __repr__(self) -> str:
        """Six lines of text on what the finite size of two bodies adds to half-planes: each value
        by its symbol, without its uncertainty.

        Values are per load: approach and tangential displacement (c_n, c_t), curvature of gap and
        slip (N, T; N_Q by Q, T_P by P), coefficients of x^4 and x^2 s^2 of the kernels (next
        order), slope of the gap (alpha), strain of the lower face minus the upper (e).

        >>> BodyEffects(datum_length=1000.0, normal_curvature=Estimate(8.5e-8, 1e-12))
        BodyEffects: what the bodies add to half-planes with a datum length of 1000
          compliance: c_n = 0, c_t = 0
          curvature: N = 8.5e-08, T = 0, N_Q = 0, T_P = 0
          next order: N_4 = 0, T_4 = 0, N_22 = 0, T_22 = 0
          tilt: alpha_P = 0, alpha_Q = 0; bulk strain: e_P = 0, e_Q = 0
          Dundurs' beta = 0; 0 unknowns, 0 factorisations
        """
        # Values by their symbols, in groups with a heading each.
        groups = (
            ("compliance: ", {"c_n": self.normal_compliance, "c_t": self.tangential_compliance}),
            (
                "curvature: ",
                {
                    "N": self.normal_curvature,
                    "T": self.tangential_curvature,
                    "N_Q": self.normal_curvature_under_shear,
                    "T_P": self.tangential_curvature_under_pressure,
                },
            ),
            (
                "next order: ",
                {
                    "N_4": self.normal_fourth,
                    "T_4": self.tangential_fourth,
                    "N_22": self.normal_mixed,
                    "T_22": self.tangential_mixed,
                },
            ),
            ("tilt: ", {"alpha_P": self.tilt_under_pressure, "alpha_Q": self.tilt_under_shear}),
            (
                "; bulk strain: ",
                {"e_P": self.strain_under_pressure, "e_Q": self.strain_under_shear},
            ),
        )
        text = (
            "BodyEffects: what the bodies add to half-planes with a datum length of"
            f" {self.datum_length:g}"
        )
        for heading, estimates in groups:
            # Bulk strain stands behind tilt, in the same line.
            text += heading if heading.startswith(";") else f"\n  {heading}"
            text += ", ".join(
                f"{symbol} = {estimate.value:.4g}" for symbol, estimate in estimates.items()
            )
        return (
            f"{text}\n  Dundurs' beta = {self.dundurs_beta:.3g}; {self.unknowns} unknowns,"
            f" {self.factorisations} factorisations"
        )
