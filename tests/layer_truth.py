"""A rigid parabola pressed without friction on an elastic layer bonded to a rigid base: neither
half-planes nor finite elements.

The surface of the layer, thickness t, sinks under a pressure p(k) cos kx by

    u(k) = 2 (1 - nu^2)/(E k) L(k t) p(k)
    L(w) = (2 kappa sinh 2w - 4w)/(2 kappa cosh 2w + 1 + kappa^2 + 4 w^2)

with kappa = 3 - 4 nu. With p = sqrt(1 - s^2) sum c_j U_2j(s), s = x/a, the part of L = 1 is in
closed form, and the rest decays like exp(-2 k t). The slope u' = -x/R is met at the zeros of
T_2N+1. Source: Johnson, Contact Mechanics (1985), section 5.8; Meijers (1968).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import eval_chebyt, eval_chebyu, jv

from scenes.array_types import Array


@dataclass(frozen=True)
class Layer:
    """Young's modulus, Poisson's ratio, thickness; radius of the parabola."""

    young_modulus: float
    poisson_ratio: float
    thickness: float
    radius: float


def coefficients(layer: Layer, half_width: float, terms: int = 24) -> Array:
    """c_j of the pressure on a contact of given half-width, (terms,) [stress]."""
    # notation: E' = E/(1 - nu^2), m = 2 j + 1
    nu = layer.poisson_ratio
    a = half_width
    plane = layer.young_modulus / (1 - nu**2)
    m = 2 * np.arange(terms) + 1
    s = np.cos((2 * np.arange(terms) + 1) * np.pi / (4 * terms + 2))  # the positive zeros of T_2N+1
    nodes, weights = np.polynomial.legendre.leggauss(60)
    ends = np.linspace(0, 22 / layer.thickness, int(22 * a / layer.thickness) + 12)
    half = (ends[1] - ends[0]) / 2
    k = (ends[:-1, None] + half * (1 + nodes)).ravel()
    dk = np.tile(half * weights, len(ends) - 1)
    w = k * layer.thickness
    kappa = 3 - 4 * nu
    low = 2 * kappa * np.sinh(2 * w) - 4 * w
    high = 2 * kappa * np.cosh(2 * w) + 1 + kappa**2 + 4 * w**2
    # of sqrt(1 - s^2) U_2j(s), cosine
    transformed = np.pi * m * (-1.0) ** (m // 2) * jv(m, k[:, None] * a) / k[:, None]
    # u(x) = 1/pi int u(k) cos kx dk over k > 0, and L = 1 gives u' = -(2/E') T_m
    rest = (
        -(2 / (np.pi * plane)) * (np.sin(np.outer(s * a, k)) * dk * (low / high - 1)) @ transformed
    )
    flat = -(2 / plane) * eval_chebyt(m[None, :], s[:, None])
    return np.linalg.solve(flat + rest, -s * a / layer.radius)


def load_on(layer: Layer, half_width: float) -> float:
    """Load per thickness that makes a contact of given half-width [force per length]."""
    return float(np.pi / 2 * half_width * coefficients(layer, half_width)[0])


def half_width_under(layer: Layer, load: float, guess: float) -> float:
    """Half-width of the contact under a load [length]."""
    return float(
        brentq(lambda a: load_on(layer, a) - load, guess / 4, guess * 4, xtol=1e-12 * guess)
    )


def pressure(layer: Layer, half_width: float, x: Array) -> Array:
    """p(x) [stress], 0 outside."""
    s = np.clip(np.abs(x) / half_width, 0, 1)
    c = coefficients(layer, half_width)
    return np.asarray(
        np.sqrt(1 - s**2) * (eval_chebyu(2 * np.arange(len(c))[None, :], s[:, None]) @ c)
    )
