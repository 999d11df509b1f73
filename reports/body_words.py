"""The two bodies of a scene in words, and what real bodies mean for the comparison."""

from __future__ import annotations

from reports.units import number, signed, units
from scenes import Block, Cylinder, HalfPlane, Pad, Scene, Shape

# Of beta, at most 1/2: rounding of like moduli written with a few digits more or less.
_NO_COUPLING = 1e-9
_SIDES = {"free": "its sides free", "guided": "its sides guided by smooth walls"}
_BASE = {"fixed": "its base fixed to a rigid plane", "rollers": "its base on rollers along a rigid plane"}


def shape_words(shape: Shape, length: str) -> str:
    """A body with its sizes and supports.

    >>> shape_words(Block(width=40.0, height=20.0, sides="guided"), "mm")
    'a block 40 mm wide and 20 mm high, its base fixed to a rigid plane, its sides guided by smooth walls'
    """
    match shape:
        case HalfPlane():
            return "a half-plane"
        case Cylinder(radius=radius):
            return f"half of a solid cylinder of radius {number(radius)} {length}, bonded to a rigid plane at its middle"
        case Block() | Pad():
            face = " whose face is the true profile" if isinstance(shape, Pad) else ""
            size = f"{number(shape.width)} {length} wide and {number(shape.height)} {length} high"
            return f"a {shape.kind} {size}{face}, {_BASE[shape.base]}, {_SIDES[shape.sides]}"


def bodies_in_words(scene: Scene) -> str:
    """Both bodies, what holds them, where the load acts and where the gap comes from."""
    lower, upper = scene.bodies.lower, scene.bodies.upper
    if scene.bodies.half_planes:
        return "Both bodies are half-planes, and the profile is the gap between their flat faces."
    length = units(scene)[1]
    parts = f"The lower body is {shape_words(lower, length)}; the upper body is {shape_words(upper, length)}."
    load = "" if isinstance(upper, HalfPlane) else " The loads act through what holds the upper body, which does not tilt."
    gap = (
        "The gap is that of the faces as they are made"
        if scene.bodies.faces_are_true
        else "The profile is the gap between flat faces"
    )
    return f"{parts}{load} {gap}."


def coupled(scene: Scene) -> bool:
    """Whether normal and shear tractions of these materials feel each other: Dundurs' beta is not 0, and there is friction."""
    if scene.material.alike or not scene.friction.coefficient:
        return False
    from halfplane_fe.dundurs import dundurs

    return abs(dundurs(scene.material).beta) >= _NO_COUPLING


def are_half_planes(scene: Scene) -> bool:
    """Whether theory is exact for the bodies of `scene`: half-planes whose normal and shear tractions do not feel each other.

    Unlike materials couple the two by Dundurs' beta, which theory leaves out: that is an idealisation too.
    """
    return scene.bodies.half_planes and not coupled(scene)


def idealisation(scene: Scene) -> str:
    """What the discrepancy of the two engines holds beside their errors; empty for half-planes for which theory is exact."""
    if are_half_planes(scene):
        return ""
    if scene.bodies.half_planes:
        return (
            "The finite elements solve the half-planes with this coupling, half-plane theory without it: the discrepancy contains "
            "that idealisation error, and a tolerance missed is a finding about the idealisation, not a fault of the engines."
        )
    causes = [
        "the size of the bodies",
        "their supports",
        *(["the true shape of their faces"] if scene.bodies.faces_are_true else []),
        *(["the coupling of normal and shear tractions by unlike materials"] if coupled(scene) else []),
    ]
    listed = ", ".join(causes[:-1]) + " and " + causes[-1]
    return (
        "The finite elements solve these real bodies, half-plane theory the half-planes that stand for them: the discrepancy "
        f"contains the idealisation error ({listed}), and a tolerance missed is a finding about the idealisation, not a fault of "
        "the engines."
    )


def unlike_materials(scene: Scene) -> str:
    """Dundurs' parameters and what they mean for half-plane theory; empty for like materials."""
    if scene.material.alike:
        return ""
    from halfplane_fe.dundurs import dundurs

    found = dundurs(scene.material)
    neglect = (
        ": half-plane theory as used here neglects the coupling of normal and shear tractions that goes with it"
        if coupled(scene)
        else ", so normal and shear tractions of half-planes are not coupled"
        if scene.friction.coefficient
        else ", which has nothing to couple without friction"
    )
    return (
        f"Unlike materials: Dundurs' parameters are α = {signed(found.alpha)} (positive where the upper body is the more "
        f"compliant) and β = {signed(found.beta)}{neglect}."
    )
