"""The two bodies: materials, shapes (half-planes, blocks, pads, cylinders, T-shapes, shouldered
pads), and their faces as they are made.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from scenes.array_types import Array
from scenes.frozen import Frozen, Positive
from scenes.profiles import Profile


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
    def _table_of_both(cls, keys: Any) -> Any:
        """Keys of both bodies: one material, or a table without `upper` and `lower`, stands for
        both.
        """
        if isinstance(keys, Elastic) or (
            isinstance(keys, dict) and not {"upper", "lower"} & keys.keys()
        ):
            return {"upper": keys, "lower": keys}
        return keys

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

    @property
    def least_depth(self) -> float:
        """Least depth of material below the face [length]."""
        return float("inf")


class WidthStep(NamedTuple):
    """Where the sides of a body jump inwards or outwards: depth below the first contact, and half
    of the width from there down to the base [length].
    """

    depth: float
    half_width: float


class _Sided(Frozen):
    """What bodies with two sides have in common."""

    kind: str
    width: Positive = Field(description="along the face, length units (library: mm)")

    @property
    def face_half_width(self) -> float:
        """Half the width of the face [length]."""
        return self.width / 2


class _Rectangle(_Sided):
    """What block and pad have in common; the base of an upper one carries the load."""

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
    def least_depth(self) -> float:
        """Least depth of material below the face [length]."""
        return self.height


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


INSTEAD_OF_HOLLOW = (
    "a hollow face is no body here: take half-planes or blocks, and the profile's relative radius"
    " by 1/R = 1/R1 - 1/R2, R2 being the hollow's"
)
"""What to do for a cylinder in a hollow."""


def _refuse_hollow(radius: Any) -> Any:
    """The radius of a cylinder as it is; ValueError for a negative one, by which contact mechanics
    states a hollow.
    """
    if isinstance(radius, int | float) and radius < 0:
        raise ValueError(INSTEAD_OF_HOLLOW)
    return radius


class Cylinder(Frozen):
    """Half of a solid cylinder, its plane of symmetry bonded to a rigid plane.

    A cylinder in a hollow is not possible: the hollow has no body.
    """

    kind: Literal["cylinder"] = "cylinder"
    radius: Annotated[Positive, BeforeValidator(_refuse_hollow)] = Field(
        description="radius of the cylinder, length units (library: mm)"
    )

    @property
    def face_half_width(self) -> float:
        """Half the width of the face [length]."""
        return self.radius

    @property
    def least_depth(self) -> float:
        """Least depth of material below the face [length]."""
        return self.radius


class TShape(_Sided):
    """Flange with a flat face on a narrower stem, the end of which is fixed to a rigid plane.

    >>> TShape(width=20.0, flange_height=6.0, stem_width=12.0, height=18.0).step
    WidthStep(depth=6.0, half_width=6.0)
    """

    kind: Literal["t_shape"] = "t_shape"
    width: Positive = Field(description="of the flange, along the face, length units (library: mm)")
    flange_height: Positive = Field(
        description="from the face to the underside of the flange, length units (library: mm)"
    )
    stem_width: Positive = Field(
        description="less than that of the flange, length units (library: mm)"
    )
    height: Positive = Field(
        description="from the face to the end of the stem, length units (library: mm)"
    )

    @property
    def least_depth(self) -> float:
        """Least depth of material below the face [length]."""
        return self.flange_height

    @property
    def step(self) -> WidthStep:
        """Where the flange ends and the stem begins."""
        return WidthStep(self.flange_height, self.stem_width / 2)

    @model_validator(mode="after")
    def _require_stem_below_flange(self) -> Self:
        """Return this T-shape if its stem is narrower than its flange, and the flange ends above
        the end of the stem; else ValueError with what is allowed.

        `width` (of the flange) and `stem_width` are along the face; `flange_height` and `height`
        (of the body) count from the face.
        """
        if self.stem_width >= self.width:
            raise ValueError(
                f"stem_width = {self.stem_width:g} is refused: it must be less than width ="
                f" {self.width:g}; take kind = 'block' for a body without a flange"
            )
        if self.flange_height >= self.height:
            raise ValueError(
                f"flange_height = {self.flange_height:g} is refused: it must be less than height ="
                f" {self.height:g}, which counts from the face to the end of the stem"
            )
        return self


class ShoulderedPad(_Sided):
    """Pad on a wider shoulder, the base of which is fixed to a rigid plane; its face is the true
    profile, as that of a pad.

    >>> ShoulderedPad(width=8.0, shoulder_depth=5.0, shoulder_width=20.0, height=15.0).step
    WidthStep(depth=5.0, half_width=10.0)
    """

    kind: Literal["shouldered_pad"] = "shouldered_pad"
    width: Positive = Field(description="of the pad, along its face, length units (library: mm)")
    shoulder_depth: Positive = Field(
        description="from the point of first contact to the shoulder, length units (library: mm)"
    )
    shoulder_width: Positive = Field(
        description="more than that of the pad, length units (library: mm)"
    )
    height: Positive = Field(
        description="from the point of first contact to the base, length units (library: mm)"
    )

    @property
    def least_depth(self) -> float:
        """Least depth of material below the face [length]."""
        return self.height

    @property
    def step(self) -> WidthStep:
        """Where the pad ends and the shoulder begins."""
        return WidthStep(self.shoulder_depth, self.shoulder_width / 2)

    @model_validator(mode="after")
    def _require_pad_on_shoulder(self) -> Self:
        """Return this pad if its shoulder is wider than the pad and lies above the base; else
        ValueError with what is allowed.

        `width` (of the pad) and `shoulder_width` are along the face; `shoulder_depth` and `height`
        (of the body) count from the point of first contact.
        """
        if self.shoulder_width <= self.width:
            raise ValueError(
                f"shoulder_width = {self.shoulder_width:g} is refused: it must be more than width ="
                f" {self.width:g}; take kind = 'pad' for a body without a shoulder"
            )
        if self.shoulder_depth >= self.height:
            raise ValueError(
                f"shoulder_depth = {self.shoulder_depth:g} is refused: it must be less than"
                f" height = {self.height:g}, which counts from the point of first contact to the"
                " base"
            )
        return self


Shape = Annotated[
    HalfPlane | Block | Pad | Cylinder | TShape | ShoulderedPad, Field(discriminator="kind")
]
_KINDS_OF_PADS = ("pad", "shouldered_pad")


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
        """Whether the gap comes from the shape of a face (pads, cylinders); else the profile is a
        gap between two flat faces.
        """
        return any(body.kind in (*_KINDS_OF_PADS, "cylinder") for body in (self.lower, self.upper))

    @model_validator(mode="after")
    def _require_contact_problem(self) -> Self:
        """Return these bodies; refuse (ValueError) two that make no contact problem: a pad on
        another pad or a cylinder, since one profile cannot be the face of both; a pad wider than
        the body it faces.

        A body's `kind` is "half_plane", "block", "pad", "cylinder", "t_shape" or "shouldered_pad".
        """
        lower_kind = self.lower.kind
        upper_kind = self.upper.kind
        # _KINDS_OF_PADS: "pad" and "shouldered_pad"
        curved_kinds = [
            kind for kind in (lower_kind, upper_kind) if kind in (*_KINDS_OF_PADS, "cylinder")
        ]
        if len(curved_kinds) == 2 and curved_kinds != ["cylinder", "cylinder"]:
            raise ValueError(
                f"a {upper_kind} on a {lower_kind}: a pad faces a half_plane, a"
                " block or a t_shape, for the profile is its own alone"
            )
        for body, name, opposite_body in (
            (self.upper, "upper", self.lower),
            (self.lower, "lower", self.upper),
        ):
            if not isinstance(body, Pad | ShoulderedPad):
                continue
            opposite_width = 2 * opposite_body.face_half_width
            if body.width > opposite_width:
                raise ValueError(
                    f"the {name} body, a pad of width {body.width:g}, is wider than the"
                    f" {opposite_body.kind} that it faces, of width {opposite_width:g}: make the"
                    f" pad narrower or the {opposite_body.kind} wider"
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
    is_flat
        whether the whole face is y = 0
    """

    depth: Callable[[Array], Array]
    arc: tuple[float, float] | None = None
    is_flat: bool = False


def arc_depth(x: Array, radius: float, flat_half_length: float = 0.0) -> Array:
    """Depth of the face of a cylinder, or of a flat with rounded edges, below its highest point
    [length], at places x along the face, in their shape.

    With b `flat_half_length`, s = |x| - b the distance from the end of the flat, and R `radius` of
    the arcs: s^2/(R + sqrt(R^2 - s^2)), that is R - sqrt(R^2 - s^2) without cancellation. It is 0
    on the flat; s is at most R.

    >>> arc_depth(np.array([0.0, 3.0, 5.0]), 5.0).tolist()
    [0.0, 1.0, 5.0]
    """
    distance = np.maximum(np.abs(x) - flat_half_length, 0.0)
    # Below 0 by round-off alone, at the very end of the arc.
    radius_minus_distance = np.maximum(radius - distance, 0.0)
    return np.asarray(distance**2 / (radius + np.sqrt(radius_minus_distance * (radius + distance))))


def face_of(shape: Shape, profile: Profile) -> Face:
    """The face of a body of this `shape`, as a function x -> depth below the point of first
    contact: flat, an arc, a flat with arcs, or the gap `profile` itself.
    """
    if not isinstance(shape, Cylinder | Pad | ShoulderedPad):
        return Face(np.zeros_like, is_flat=True)
    # half the length of the flat, and radius of the arcs; None where the face is no arc
    arc = (0.0, shape.radius) if isinstance(shape, Cylinder) else profile.arc
    return (
        Face(profile.height) if arc is None else Face(lambda x: arc_depth(x, arc[1], arc[0]), arc)
    )
