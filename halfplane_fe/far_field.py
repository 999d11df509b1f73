"""Displacement of a half-plane by point forces on its surface (Flamant): the piece of half-plane theory inside the FE model.

The arc of the half-disc follows the displacement of the very nodal forces on the contact, each at its own place. So the
multipoles of every order are there, and what is left of the far field's error is that of the forces' being points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def surface_force_displacement(
    x: Array, y: Array, force_at: Array, young_modulus: float, poisson_ratio: float, datum_length: float
) -> Array:
    r"""Displacements of the half-plane y <= 0 by unit forces on its surface.

    With r the distance, z = -y, theta = atan2(x, z), G the shear modulus and c = 1/(2 pi G):

        force along x:  u_x = -c [2 (1-nu) ln(r/L) + z^2/r^2],      u_z = c [x z/r^2 + (1-2 nu) theta]
        force along z:  u_x =  c [x z/r^2 - (1-2 nu) theta],        u_z = -c [2 (1-nu) ln(r/L) - z^2/r^2]

    so that the surface at distance L (`datum_length`) from the force does not move along the force.

    Parameters
    ----------
    x, y : (n,) points, y <= 0, none at a force [length]
    force_at : (m,) places of the forces on the surface [length]

    Returns
    -------
    (2, n, 2, m)
        Displacement component (x, y), point, force component (x, y), place [length per force per thickness].

    Source: Johnson, Contact Mechanics (1985), sections 2.2 and 2.3, in Cartesian form.
    """
    # notation: c = 1/(2 pi G), k = 1 - 2 nu
    shear_modulus = young_modulus / (2 * (1 + poisson_ratio))
    c, k = 1 / (2 * np.pi * shear_modulus), 1 - 2 * poisson_ratio
    dx = x[:, None] - force_at[None, :]
    z = np.broadcast_to(-y[:, None], dx.shape)
    r2 = dx**2 + z**2
    log = (1 + k) * np.log(np.sqrt(r2) / datum_length)
    twist, cross, depth = k * np.arctan2(dx, z), dx * z / r2, z**2 / r2
    along_x = np.stack([-c * (log + depth), -c * (cross + twist)])
    # A force along +y is a force along -z, and u_y = -u_z.
    along_y = np.stack([-c * (cross - twist), -c * (log - depth)])
    return np.stack([along_x, along_y], axis=2)
