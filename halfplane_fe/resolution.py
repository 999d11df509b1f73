"""What the mesh can't see, in sentences: slip zones and flanks of the pressure that are narrower than a few elements."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from scenes import Scene

Array = NDArray[np.float64]

# Elements below which the dissipation of a slip zone is off by per cents: Cattaneo and Mindlin's cycle has 0.4 % at 3.4 elements,
# 3 % at 1.6, and is three times too large or nothing at 0.2.
_FEW = 2.0
# The same for p at the end of a flat face: 2.4 % in L2 at 3.2 elements, 27 % at 0.03.
_FEW_OF_FLANK = 4.0


def resolution_notes(
    scene: Scene, contact: Array, stick: Array, element: float, dissipation: float, sheared: bool
) -> Iterator[str]:
    """One sentence for whatever is too narrow for surface elements of size `element` [length].

    Parameters
    ----------
    contact, stick : (n,) half-widths at the instants of the last cycle [length]; stick NaN where nothing sticks
    sheared : whether any shear can arise
    """
    widest = float(np.max(contact, initial=0.0))
    zones = contact - np.where(np.isfinite(stick), stick, 0.0)
    slip = float(np.max(zones, initial=0.0)) / element
    if sheared and not dissipation > 0:
        yield (
            f"no node slips: a slip zone narrower than an element, {element:.3g} at the edges, would not be seen, and its "
            "dissipation would be missing"
        )
    elif sheared and slip < _FEW:
        yield (
            f"slip zones are {slip:.2g} elements wide at most, {element:.3g} each: the dissipation is off by per cents or more; "
            "make edge_element_size several times less than their width"
        )
    for kink in scene.profile.kinks:
        beyond = (widest - kink) / element
        if -1 < beyond < _FEW_OF_FLANK:
            yield (
                f"the contact ends {beyond:.2g} elements, {element:.3g} each, beyond x = {kink:.6g}, where the pressure is steep: "
                f"it is not resolved there; make edge_element_size {_FEW_OF_FLANK:g} times less than that distance"
            )
