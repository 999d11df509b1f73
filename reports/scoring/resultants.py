"""What a result's own tractions add up to, as sentences where they add up to something else than they should."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reports.scoring.guesses import TOUCHES

Array = NDArray[np.float64]

_ADDS_UP = 0.02  # below what trapezia over ten elements a half-width lose at a square-root edge
_CARRIES = 0.01  # of the largest pressure: below it a point counts as free where nothing else tells


def tension(pressure: Array) -> list[str]:
    """A sentence where the contact pulls a little; `guesses.oddities` names what is more, with its place.

    >>> tension(np.array([[100.0, -0.05]]))
    ['the contact pulls at some points, by up to 0.05: kept as it is (a linear overclosure law allows it)']
    >>> tension(np.array([[100.0, -1.5]]))
    []
    """
    least = float(pressure.min())
    if least >= 0 or least < -TOUCHES * float(pressure.max()):
        return []
    return [f"the contact pulls at some points, by up to {-least:.4g}: kept as it is (a linear overclosure law allows it)"]


def unbalanced(x: Array, pressure: Array, normal_load: Array | None) -> list[str]:
    """A sentence where the pressure does not add up to the pair's resultant: nodal values of surface-to-surface pairs do not."""
    if normal_load is None or normal_load[-1] == 0:
        return []
    share = float(np.trapezoid(pressure[-1], x) / normal_load[-1])
    if abs(share - 1) < _ADDS_UP:
        return []
    return [f"the last instant's pressures add up to {share:.3f} of the contact pair's resultant: so coarse are the file's values"]


def free_face(x: Array, pressure: Array, shear: Array) -> list[str]:
    """A sentence where stress taken for traction leaves shear on the free face beside the contact.

    At the instant of the largest pressure, over the points that carry less than a hundredth of it; the elements are large there, so
    that little stress adds up to much load.

    >>> x = np.linspace(-2, 2, 5)
    >>> free_face(x, np.array([[0.0, 1, 2, 1, 0]]), np.array([[0.1, 0.5, 1, 0.5, 0.1]]))
    ['the stress leaves shear on the face beside the contact, which adds 5.0 % to what the shear adds up to: kept as it is']
    """
    k = int(np.argmax(pressure.max(axis=1)))
    touching = pressure[k] > _CARRIES * pressure[k].max()
    whole = float(np.trapezoid(shear[k], x))
    inside = float(np.trapezoid(np.where(touching, shear[k], 0.0), x))
    if inside == 0 or abs(whole / inside - 1) < _ADDS_UP:
        return []
    excess = whole / inside - 1
    return [
        f"the stress leaves shear on the face beside the contact, which adds {100 * excess:.1f} % to what the shear adds up to: "
        "kept as it is"
    ]
