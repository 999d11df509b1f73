"""Displacement of a half-plane by point forces on its surface (Flamant): the piece of half-plane theory inside the FE model.

The arc of the half-disc follows the displacement of the very nodal forces on the contact, each at its own place. So the
multipoles of every order are there, and what is left of the far field's error is that of the forces' being points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def surface_force_displacement(
    x: Array,
    y: Array,
    force_at: Array,
    young_modulus: float,
    poisson_ratio: float,
    datum_length: float,
    moments: int | None = None,
) -> Array:
    r"""Displacements of the half-plane y <= 0 by unit forces on its surface.

    With r the distance, z = -y, theta = atan2(x, z), G the shear modulus and c = 1/(2 pi G):

        force along x:  u_x = -c [2 (1-nu) ln(r/L) + z^2/r^2],      u_z = c [x z/r^2 + (1-2 nu) theta]
        force along z:  u_x =  c [x z/r^2 - (1-2 nu) theta],        u_z = -c [2 (1-nu) ln(r/L) - z^2/r^2]

    so that the surface at distance L (`datum_length`) from the force does not move along the force. With x the distance from the
    force at s, w = z + i x is w_0 - i s, and the multipoles are the powers of s in

        ln r + i theta = ln w = ln w_0 - sum_k (i s/w_0)^k / k,        (z^2 - i x z)/r^2 = z/w = (z/w_0) sum_k (i s/w_0)^k:

    the displacement by many forces f_j is the sum over k of their moments sum_j f_j s_j^k times the field of the k-th one.

    Parameters
    ----------
    x, y : (n,) points, y <= 0, none at a force [length]
    force_at : (m,) places of the forces on the surface [length]
    moments : highest moment that is taken, 0 for the resultants alone at x = 0 (for studies; the body has to reach beyond every
        force); None for all of them, summed exactly

    Returns
    -------
    (2, n, 2, m)
        Displacement component (x, y), point, force component (x, y), place [length per force per thickness].

    Source: Johnson, Contact Mechanics (1985), sections 2.2 and 2.3, in Cartesian form.
    """
    # notation: c = 1/(2 pi G), k = 1 - 2 nu
    shear_modulus = young_modulus / (2 * (1 + poisson_ratio))
    c, k = 1 / (2 * np.pi * shear_modulus), 1 - 2 * poisson_ratio
    logarithm, quotient = _potentials(x, -y, force_at, moments)
    log, twist = (1 + k) * (logarithm.real - np.log(datum_length)), k * logarithm.imag
    depth, cross = quotient.real, -quotient.imag
    along_x = np.stack([-c * (log + depth), -c * (cross + twist)])
    # A force along +y is a force along -z, and u_y = -u_z.
    along_y = np.stack([-c * (cross - twist), -c * (log - depth)])
    return np.stack([along_x, along_y], axis=2)


def _potentials(x: Array, z: Array, force_at: Array, moments: int | None) -> tuple[Complex, Complex]:
    """ln w and z/w (n, m), w = z + i (x - force_at), or their series in the places of the forces up to a power."""
    if moments is None:
        w: Complex = z[:, None] + 1j * (x[:, None] - force_at)
        return np.log(w), z[:, None] / w
    centre: Complex = (z + 1j * x)[:, None]
    powers = (1j * force_at / centre)[..., None] ** np.arange(moments + 1)
    series = (powers[..., 1:] / np.arange(1, moments + 1)).sum(axis=-1)
    return np.log(centre) - series, z[:, None] / centre * powers.sum(axis=-1)
