"""The two bodies: half-planes, as the theory has them, or blocks, pads and cylinders, as engineers have them."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from scenes.frozen import Frozen
from scenes.materials import Positive

Base = Literal["fixed", "rollers"]
Sides = Literal["free", "guided"]


class HalfPlane(Frozen):
    """Half-plane with a flat face: what half-plane theory is about."""

    kind: Literal["half_plane"] = "half_plane"

    @property
    def face_half_width(self) -> float:
        """Half the width of the face [length]."""
        return float("inf")


class _Rectangle(Frozen):
    """What block and pad have in common; the base of an upper one carries the load."""

    kind: str
    width: Positive = Field(description="along the face, length units (library: mm)")
    height: Positive = Field(description="from the face, a pad's point of first contact, to the base, length units (library: mm)")
    base: Base = Field("fixed", description="fixed to the rigid plane, or on rollers: free to slide along it")
    sides: Sides = Field("free", description="free, or guided: free to slide along smooth walls")

    @property
    def face_half_width(self) -> float:
        """Half the width of the face [length]."""
        return self.width / 2


class Block(_Rectangle):
    """Rectangle with a flat face; its base is a rigid plane, which carries the load where the block is the upper body.

    >>> Block(width=40.0, height=20.0).face_half_width
    20.0
    """

    kind: Literal["block"] = "block"


class Pad(_Rectangle):
    """Rectangle whose face is the true profile: an arc for "hertz", a flat with arcs for "flat_rounded", h(x) for all others."""

    kind: Literal["pad"] = "pad"


class Cylinder(Frozen):
    """Half of a solid cylinder, its plane of symmetry bonded to a rigid plane (which carries the load of an upper body)."""

    kind: Literal["cylinder"] = "cylinder"
    radius: Positive = Field(description="length units (library: mm)")

    @property
    def face_half_width(self) -> float:
        """Half the width of the face [length]."""
        return self.radius


Shape = Annotated[HalfPlane | Block | Pad | Cylinder, Field(discriminator="kind")]


class Bodies(Frozen):
    """The shapes of the two bodies, both mirror-symmetric in x = 0; half-planes where they are left out.

    >>> Bodies().half_planes, Bodies(upper=Pad(width=12.0, height=10.0)).faces_are_true
    (True, True)
    """

    lower: Shape = HalfPlane()
    upper: Shape = HalfPlane()

    @property
    def half_planes(self) -> bool:
        """Whether both are half-planes."""
        return self.lower.kind == self.upper.kind == "half_plane"

    @property
    def faces_are_true(self) -> bool:
        """Whether the gap comes from the shape of a face (pad, cylinder); else the profile is a gap between two flat faces."""
        return any(body.kind in ("pad", "cylinder") for body in (self.lower, self.upper))

    @model_validator(mode="after")
    def _fit_together(self) -> Self:
        kinds = (self.lower.kind, self.upper.kind)
        if kinds.count("pad") == 2 or set(kinds) == {"pad", "cylinder"}:
            raise ValueError(f"a {kinds[1]} on a {kinds[0]}: a pad faces a half_plane or a block, for the profile is its own alone")
        for pad, name, other in ((self.upper, "upper", self.lower), (self.lower, "lower", self.upper)):
            if pad.kind == "pad" and pad.face_half_width > other.face_half_width:
                raise ValueError(
                    f"the {name} body, a pad of width {pad.width:g}, is wider than the {other.kind} that it faces, of width "
                    f"{2 * other.face_half_width:g}: make the pad narrower or the {other.kind} wider"
                )
        return self

    def relative_radius(self) -> float | None:
        """R of the gap x^2/(2 R) that cylinders make with what they face; None where there is no cylinder."""
        curvature = sum(1 / body.radius for body in (self.lower, self.upper) if isinstance(body, Cylinder))
        return 1 / curvature if curvature else None
