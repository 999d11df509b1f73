"""What of a rig is between its actuators and the contact: springs, and the datum of half-planes."""

from __future__ import annotations

from pydantic import Field

from scenes.frozen import Frozen, Positive


class Rig(Frozen):
    """Stiffness of a rig whose actuators prescribe displacements; a key that is left out is a stiff
    rig.

    The actuator moves by U + Q/k_s, U being the tangential displacement of the contact and k_s
    `tangential_stiffness`; likewise by the approach + P/k_n.

    >>> Rig(tangential_stiffness=2000.0).normal_stiffness is None
    True
    """

    tangential_stiffness: Positive | None = Field(
        None,
        description=(
            "k_s between the tangential actuator and the bodies, load per length per unit"
            " thickness; infinite if left out (library: N/mm per mm)"
        ),
    )
    normal_stiffness: Positive | None = Field(
        None,
        description=(
            "k_n between the normal actuator and the bodies, likewise (library: N/mm per mm)"
        ),
    )
    datum_length: Positive | None = Field(
        None,
        description=(
            "of half-planes alone: distance from the contact at which a displacement is"
            " prescribed, length units (library: mm)"
        ),
    )

    @property
    def is_stated(self) -> bool:
        """Whether any key is stated."""
        return any(value is not None for _, value in self)
