"""What of a rig is between its actuators and the contact: springs, and the datum of half-planes."""

from __future__ import annotations

from pydantic import Field

from scenes.frozen import Frozen, Positive


class Rig(Frozen):
    """Stiffness of a rig whose actuators prescribe displacements; a key that is left out is a stiff
    rig.

    The scene states U_act of the actuator, an answer U of the contact: U_act = U + Q/k_s, k_s being
    `tangential_stiffness`; likewise the approach + P/k_n. Of half-planes an answer's U counts from
    the datum of every answer, not from `datum_length`.

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
