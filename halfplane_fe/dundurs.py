"""Dundurs' parameters: how unlike two bodies are, as far as plane contact can tell."""

from __future__ import annotations

from typing import NamedTuple

from scenes import Materials


class Dundurs(NamedTuple):
    """alpha in [-1, 1] and beta in [-1/2, 1/2]; alpha is positive where the upper body is the more
    compliant one.
    """

    alpha: float
    beta: float


def dundurs(material: Materials) -> Dundurs:
    """Dundurs' parameters alpha and beta, which measure how unlike the two materials of a plane
    contact are; plane strain, body 1 is the upper one.

        alpha = [(1 - nu1)/G1 - (1 - nu2)/G2] / s,   s = (1 - nu1)/G1 + (1 - nu2)/G2
        beta  = [(1 - 2 nu1)/G1 - (1 - 2 nu2)/G2] / (2 s)

    beta couples normal and shear tractions of half-planes; the half-plane theory of this project
    needs beta = 0. alpha matters only where a body has a finite size. Both are 0 of like materials.

    # notation: nu Poisson's ratio, G shear modulus, s sum of the compliances

    Source: J. Dundurs, J. Appl. Mech. 36 (1969) 650; K. L. Johnson, Contact Mechanics (1985),
    equations (5.3).

    >>> from scenes import Elastic
    >>> rigid, rubber = (
    ...     Elastic(young_modulus=1e12, poisson_ratio=0.3),
    ...     Elastic(young_modulus=1.0, poisson_ratio=0.25),
    ... )
    >>> [
    ...     round(value, 6) for value in dundurs(Materials(upper=rubber, lower=rigid))
    ... ]  # (1 - 2 nu)/(2 (1 - nu)) = 1/3
    [1.0, 0.333333]
    """
    nu1 = material.upper.poisson_ratio
    nu2 = material.lower.poisson_ratio
    G1 = material.upper.young_modulus / (2 * (1 + nu1))
    G2 = material.lower.young_modulus / (2 * (1 + nu2))
    s = (1 - nu1) / G1 + (1 - nu2) / G2
    alpha = ((1 - nu1) / G1 - (1 - nu2) / G2) / s
    beta = ((1 - 2 * nu1) / G1 - (1 - 2 * nu2) / G2) / (2 * s)
    return Dundurs(alpha, beta)
