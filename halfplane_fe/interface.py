"""The interface of two condensed bodies as one value: what nodal contact forces do to gap and slip.

    g = h - delta + N p - K^T q          gap, delta the rigid approach
    s = U + K p - T q                    slip of the upper face over the lower, U the rigid shift

p and q are nodal forces (pressure and shear times weight), p pressing and q along +x on the lower body. N and T are symmetric,
K couples: it is exactly zero for like bodies on matching meshes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.mortar import mortar_projection
from scenes import freeze

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Interface:
    """Compliance of a pair of bodies, both half-planes facing each other.

    Attributes
    ----------
    x, weights : (n,) contact points of the lower body and their share of the surface [length]
    normal, tangential : (n, n) N and T [length per force per thickness]
    coupling : (n, n) K, or None where the bodies are alike
    """

    x: Array
    weights: Array
    normal: Array
    tangential: Array
    coupling: Array | None

    def scaled(self, length: float, compliance: float) -> Interface:
        """The same interface in other units: lengths over `length`, compliances over `compliance`."""
        return Interface(
            freeze(self.x / length),
            freeze(self.weights / length),
            freeze(self.normal / compliance),
            freeze(self.tangential / compliance),
            None if self.coupling is None else freeze(self.coupling / compliance),
        )


def couple(lower: CondensedBody, upper: CondensedBody) -> Interface:
    """Couple two bodies node by node where their contact nodes lie opposite each other, by mortar where they do not.

    The upper body is condensed in its own frame, as if it were a lower one, and reflected in y = 0 here.
    """
    # compliance[i, :, j, :]: displacement i (0 along x, 1 outward) by force j; the upper body feels -q along x and -p outward.
    above = upper.compliance
    if not _matching(lower, upper):
        projection = mortar_projection(lower.x, upper.x, lower.order)
        above = np.einsum("pj,ijkl,ql->ipkq", projection, above, projection, optimize=True)
    alike = lower.material == upper.material and _matching(lower, upper)
    return Interface(
        lower.x,
        lower.weights,
        freeze(lower.compliance[1, :, 1, :] + above[1, :, 1, :]),
        freeze(lower.compliance[0, :, 0, :] + above[0, :, 0, :]),
        None if alike else freeze(lower.compliance[0, :, 1, :] - above[0, :, 1, :]),
    )


def _matching(lower: CondensedBody, upper: CondensedBody) -> bool:
    return lower.x.shape == upper.x.shape and bool(np.allclose(lower.x, upper.x, rtol=0, atol=1e-9 * np.ptp(lower.x)))


def body_forces(lower: CondensedBody, upper: CondensedBody, pressure: Array, shear: Array) -> dict[str, Array]:
    """(2, n) nodal forces (along x, outward) on each body in its own frame, "lower" and "upper", from nodal p and q."""
    below = np.stack([shear, -pressure])
    above = np.stack([-shear, -pressure])
    if not _matching(lower, upper):
        above = above @ mortar_projection(lower.x, upper.x, lower.order)
    return {"lower": below, "upper": above}
