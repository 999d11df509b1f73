"""The one form that every foreign result is read into, whatever file it came from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SurfaceResult:
    """Tractions on the contact surface as somebody else computed them, in the scene's units and in our signs.

    Attributes
    ----------
    source : where it was read, for the page and for sentences
    code : what computed it, such as "CalculiX 2.20"; "" where nobody says
    x : (n_points,), contact points of the lower body, ascending [length]
    pressure, shear : (n_steps, n_points) [stress]; pressure positive in compression, shear along +x on the lower body
    slip : (n_steps, n_points) [length], upper over lower; None where the file has none
    time : (n_steps,), times of the scene's load path; None where the file has none
    normal_load, tangential_load : (n_steps,), loads per unit thickness as the file states them; None where it does not
    notes : everything that a reader must not miss: factors guessed, signs turned, frames left out
    """

    source: str
    code: str
    x: Array
    pressure: Array
    shear: Array
    slip: Array | None = None
    time: Array | None = None
    normal_load: Array | None = None
    tangential_load: Array | None = None
    notes: tuple[str, ...] = ()
