"""What half-plane theory takes from the two materials: the composite modulus and Dundurs' second
constant.
"""

from __future__ import annotations

from scenes import Elastic, Materials


def composite_modulus(materials: Materials) -> float:
    """E* of 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [stress] (theory of Hertz, plane strain).

    >>> material = Elastic(young_modulus=182.0, poisson_ratio=0.3)
    >>> round(composite_modulus(Materials(upper=material, lower=material)), 12)
    100.0
    """
    bodies = (materials.upper, materials.lower)
    return 1 / sum((1 - body.poisson_ratio**2) / body.young_modulus for body in bodies)


def shear_modulus(material: Elastic) -> float:
    """G = E / (2 (1 + nu)) [stress].

    >>> shear_modulus(Elastic(young_modulus=2.5, poisson_ratio=0.25))
    1.0
    """
    return material.young_modulus / (2 * (1 + material.poisson_ratio))


def coupling_constant(materials: Materials) -> float:
    """Dundurs' constant beta of two materials in plane strain: 0 if pressure causes no relative
    tangential displacement of the faces, at most 1/2 in magnitude. Positive: upper body softer in
    (1 - 2 nu)/G.

        beta = [(1 - 2 nu1)/G1 - (1 - 2 nu2)/G2] / [2 (1 - nu1)/G1 + 2 (1 - nu2)/G2]

    # notation: G shear modulus, nu Poisson's ratio; 1 the upper body, 2 the lower one

    >>> soft_body = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    >>> stiff_body = Elastic(young_modulus=2e9, poisson_ratio=0.0)
    >>> round(coupling_constant(Materials(upper=soft_body, lower=stiff_body)), 6)
    0.5
    """
    nu_1 = materials.upper.poisson_ratio
    nu_2 = materials.lower.poisson_ratio
    g_1 = shear_modulus(materials.upper)
    g_2 = shear_modulus(materials.lower)
    # numerator of beta, then half of its denominator
    coupling_difference = (1 - 2 * nu_1) / g_1 - (1 - 2 * nu_2) / g_2
    compliance_sum = (1 - nu_1) / g_1 + (1 - nu_2) / g_2
    return coupling_difference / (2 * compliance_sum)
