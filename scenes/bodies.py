"""The two bodies: materials, shapes (half-planes, blocks, pads, cylinders), and their faces as they
are made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from scenes.frozen import Frozen, Positive
from scenes.profiles import Profile

Array = NDArray[np.float64]


class Elastic(Frozen):
    """One isotropic linear elastic material in plane strain.

    >>> Elastic(young_modulus=210e3, poisson_ratio=0.3).poisson_ratio
    0.3
    """

    young_modulus: Positive = Field(description="Young's modulus, stress units (library: MPa)")
    poisson_ratio: float = Field(gt=-1, lt=0.5, description="Poisson's ratio")


class Materials(Frozen):
    """The materials of the two bodies; one material, or one table without `upper` and `lower`,
    stands for both.

    >>> Materials.model_validate(Elastic(young_modulus=70e3, poisson_ratio=0.33)).alike
    True
    >>> Materials.model_validate({"young_modulus": 70e3, "poisson_ratio": 0.33}).alike
    True
    """

    upper: Elastic
    lower: Elastic

    @model_validator(mode="before")
    @classmethod
    def _one_for_both(cls, data: Any) -> Any:
        if isinstance(data, Elastic) or (
            isinstance(data, dict) and not {"upper", "lower"} & data.keys()
        ):
            return {"upper": data, "lower": data}
        return data

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """As for every table; keys of a material without `upper` and `lower` change both bodies."""
        return super().merged(
            changes if {"upper", "lower"} & changes.keys() else {"upper": changes, "lower": changes}
        )

    @property
    def alike(self) -> bool:
        """Whether both bodies are of one material."""
        return self.upper == self.lower


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
    height: Positive = Field(
        description=(
            "from the face, a pad's point of first contact, to the base, length units (library: mm)"
        )
    )
    base: Literal["fixed", "rollers"] = Field(
        "fixed", description="fixed to the rigid plane, or on rollers: free to slide along it"
    )
    sides: Literal["free", "guided"] = Field(
        "free", description="free, or guided: free to slide along smooth walls"
    )

    @property
    def face_half_width(self) -> float:
        """Half the width of the face [length]."""
        return self.width / 2


class Block(_Rectangle):
    """Rectangle with a flat face; its base is a rigid plane, which carries the load where the block
    is the upper body.

    >>> Block(width=40.0, height=20.0).face_half_width
    20.0
    """

    kind: Literal["block"] = "block"


class Pad(_Rectangle):
    """Rectangle whose face is the true profile: an arc for "hertz", a flat with arcs for
    "flat_rounded", h(x) for all others.
    """

    kind: Literal["pad"] = "pad"


class Cylinder(Frozen):
    """Half of a solid cylinder, its plane of symmetry bonded to a rigid plane (which carries the
    load of an upper body).
    """

    kind: Literal["cylinder"] = "cylinder"
    radius: Positive = Field(description="radius of the cylinder, length units (library: mm)")

    @property
    def face_half_width(self) -> float:
        """Half the width of the face [length]."""
        return self.radius


Shape = Annotated[HalfPlane | Block | Pad | Cylinder, Field(discriminator="kind")]


class Bodies(Frozen):
    """The shapes of the two bodies, both mirror-symmetric in x = 0; half-planes where they are left
    out.

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
        """Whether the gap comes from the shape of a face (pad, cylinder); else the profile is a gap
        between two flat faces.
        """
        return any(body.kind in ("pad", "cylinder") for body in (self.lower, self.upper))

    @model_validator(mode="after")
    def _fit_together(self) -> Self:
        kinds = (self.lower.kind, self.upper.kind)
        if kinds.count("pad") == 2 or set(kinds) == {"pad", "cylinder"}:
            raise ValueError(
                f"a {kinds[1]} on a {kinds[0]}: a pad faces a half_plane or a block, for the"
                " profile is its own alone"
            )
        for pad, name, other in (
            (self.upper, "upper", self.lower),
            (self.lower, "lower", self.upper),
        ):
            if pad.kind == "pad" and pad.face_half_width > other.face_half_width:
                raise ValueError(
                    f"the {name} body, a pad of width {pad.width:g}, is wider than the {other.kind}"
                    f" that it faces, of width {2 * other.face_half_width:g}: make the pad narrower"
                    f" or the {other.kind} wider"
                )
        return self

    def relative_radius(self) -> float | None:
        """R of the gap x^2/(2 R) that cylinders make with what they face; None where there is no
        cylinder.
        """
        curvature = sum(
            1 / body.radius for body in (self.lower, self.upper) if isinstance(body, Cylinder)
        )
        return 1 / curvature if curvature else None


@dataclass(frozen=True)
class Face:
    """One side of the contact, mirror-symmetric in x = 0, in the body's own frame (y out of the
    body).

    Attributes
    ----------
    depth
        how far the face at x lies below its point of first contact [length]; any shape
    arc
        centre (x > 0 half) and radius of the arc that the face is from some place outwards, or
        None
    flat
        whether the whole face is y = 0
    """

    depth: Callable[[Array], Array]
    arc: tuple[float, float] | None = None
    flat: bool = False


def arc_depth(x: Array, radius: float, flat_half_length: float = 0.0) -> Array:
    """Depth d = s^2/(R + sqrt(R^2 - s^2)) of an arc of radius R that starts at the end of a flat, s
    = |x| - b; |s| <= R.

    >>> arc_depth(np.array([0.0, 3.0, 5.0]), 5.0).tolist()
    [0.0, 1.0, 5.0]
    """
    beyond = np.maximum(np.abs(x) - flat_half_length, 0.0)
    rest = np.maximum(radius - beyond, 0.0)  # negative by rounding at the very end of the arc
    return np.asarray(beyond**2 / (radius + np.sqrt(rest * (radius + beyond))))


def face_of(shape: Shape, profile: Profile) -> Face:
    """The face of a body: flat, an arc, a flat with arcs, or the profile itself."""
    if not isinstance(shape, Cylinder | Pad):
        return Face(np.zeros_like, flat=True)
    arc = profile.arc if isinstance(shape, Pad) else (0.0, shape.radius)
    return (
        Face(profile.height) if arc is None else Face(lambda x: arc_depth(x, arc[1], arc[0]), arc)
    )
