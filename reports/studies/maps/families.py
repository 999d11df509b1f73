"""The kinds of body that the maps show, each as scenes over its height, its width and friction.

All of steel, in half-widths of contact at the mean load: a = 1 mm by half-plane theory. The load
cycle is the paper's, its tangential loads in proportion to friction. Of pads the radius of the arcs
is the height.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from scenes import EllipseLoad, InputError, Scene, load_scene
from semi_analytic.profiles import contact_of

# Radius of the profile between flat bodies [mm]: a of Hertz' contact does not depend on it.
_RADIUS = 1000.0
_WIDTH_OF_LAYER = 12.0
# Shares of the width of the flange, and of its height.
_STEM_OF_FLANGE = 0.6
_HEIGHT_OF_T = 3.0
# The face of a flat pad reaches so far beyond its flat, over the radius of its edges: at 8 a and
# above contact ends long before.
_LENGTH_BESIDE_FLAT = 0.7
_HALF_PLANE = {"kind": "half_plane"}
_FRICTIONS = (0.3, 0.9)
_HEIGHTS = (4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0)
# Heights at which finite elements check a map: the least one, and one at which theory errs by some
# per cent.
_CHECKED_HEIGHTS = (4.0, 12.0)


class Place(NamedTuple):
    """A point of a map.

    Attributes
    ----------
    height
        of the body, of pads the radius too, over a
    width
        second coordinate of the kind
    friction
        f
    """

    height: float
    width: float
    friction: float


@dataclass(frozen=True)
class Kind:
    """A kind of body.

    Attributes
    ----------
    name, title, shape
        of its map, in words: what h and the second coordinate are of
    height_words, width_words
        of both coordinates
    bodies
        lower and upper body, from height and width
    widths, frictions, heights, checked_heights
        coordinates of its points; heights at which finite elements check it
    is_curved
        whether its faces are arcs, of radius h: no numbers of the bodies, no edge tension
    is_flat_pad
        whether its arcs lie beside a flat, the second coordinate being b/a
    """

    name: str
    title: str
    shape: str
    bodies: Callable[[float, float], dict[str, Any]]
    widths: tuple[float, ...]
    height_words: str = "height/a"
    width_words: str = "width/height"
    frictions: tuple[float, ...] = _FRICTIONS
    heights: tuple[float, ...] = _HEIGHTS
    checked_heights: tuple[float, ...] = _CHECKED_HEIGHTS
    is_curved: bool = False
    is_flat_pad: bool = False

    def scene(self, place: Place) -> Scene:
        """The scene at a point of a map of errors (`place`: height, width, friction coefficient).
        It has bodies of this kind, a profile, and the mean load at which the half-width a is 1 mm.
        The amplitudes of the loads have the paper's proportions to the mean.

        `is_curved`: the faces are arcs, whose radius is the height; `is_flat_pad`: they have a flat
        between the arcs, whose half-length is the width. `bodies` makes both bodies from height and
        width.
        """
        # between flat faces a parabola of radius 1000 mm (_RADIUS), on which a does not depend
        profile: dict[str, Any] = {"kind": "hertz", "radius": _RADIUS}
        if self.is_curved:
            profile["radius"] = place.height
        if self.is_flat_pad:
            profile |= {"kind": "flat_rounded", "flat_half_length": place.width}
        scene = load_scene("hertz-paper").vary(
            name=f"map-{self.name}",
            title=f"{self.title}, map of the idealisation error",
            profile=profile,
            bodies=self.bodies(place.height, place.width),
            friction=place.friction,
            expected=[],
        )

        # the load P0 at which the contact's half-width is 1 mm; P1 = P0/3, Q1 = f P0/3
        mean_load = float(contact_of(scene.profile, scene.material).load(1.0))
        load_ellipse = EllipseLoad(
            mean_normal_load=mean_load,
            normal_amplitude=mean_load / 3,
            mean_tangential_load=1.1 / 3 * place.friction * mean_load,
            tangential_amplitude=place.friction * mean_load / 3,
            phase_degrees=90.0,
            initial_loading="straight",
        )
        return scene.vary(load=load_ellipse)

    def places(self, heights: tuple[float, ...]) -> list[Place]:
        """The points of a map at these heights: for each width and friction coefficient all
        heights, one after the other.
        """
        return [
            Place(height, width, friction)
            for width in self.widths
            for friction in self.frictions
            for height in heights
        ]


def _block(height: float, width: float) -> dict[str, Any]:
    return {"kind": "block", "width": width * height, "height": height}


def _t_shape(flange_height: float, width: float) -> dict[str, Any]:
    """Keys of a T-shaped body, from the height of its flange and the flange's width over that."""
    flange_width = width * flange_height
    return {
        "kind": "t_shape",
        "width": flange_width,
        "flange_height": flange_height,
        "stem_width": _STEM_OF_FLANGE * flange_width,
        "height": _HEIGHT_OF_T * flange_height,
    }


def _flat_pad(radius: float, flat_half_length: float) -> dict[str, Any]:
    width = 2 * (flat_half_length + _LENGTH_BESIDE_FLAT * radius)
    return {"kind": "pad", "width": width, "height": radius}


KINDS = {
    kind.name: kind
    for kind in (
        Kind(
            "block",
            "One block",
            "One block on a fixed base, sides free, under a half-plane.",
            lambda height, width: {"lower": _block(height, width), "upper": _HALF_PLANE},
            (1.0, 2.0),
        ),
        Kind(
            "pair",
            "Two equal blocks",
            "Two equal blocks on fixed bases, sides free. Friction does not move their error.",
            lambda height, width: {"lower": _block(height, width), "upper": _block(height, width)},
            (1.0, 2.0),
            frictions=(0.6,),
        ),
        Kind(
            "layer",
            "A layer",
            "A layer on a fixed base, 12 times as wide as high, under a half-plane.",
            lambda height, width: {"lower": _block(height, width), "upper": _HALF_PLANE},
            (_WIDTH_OF_LAYER,),
        ),
        Kind(
            "t-shape",
            "A T-shape",
            "A flange, whose size counts, on a stem 0.6 times as wide, 3 times as high in"
            " all, under a half-plane.",
            lambda height, width: {"lower": _t_shape(height, width), "upper": _HALF_PLANE},
            (3.0,),
            heights=_HEIGHTS[1:],
            checked_heights=(6.0, 16.0),
        ),
        Kind(
            "pad",
            "A round pad",
            "A pad as high as the radius R of its face, on a half-plane.",
            lambda height, width: {
                "lower": _HALF_PLANE,
                "upper": {"kind": "pad", "width": width * height, "height": height},
            },
            (1.0, 1.6),
            height_words="R/a",
            heights=_HEIGHTS[1:],
            checked_heights=(8.0, 16.0),
            is_curved=True,
        ),
        Kind(
            "flat-pad",
            "A flat pad with rounded edges",
            "A pad as high as the radius R of its edges, its flat 2b wide, on a half-plane.",
            lambda height, width: {"lower": _HALF_PLANE, "upper": _flat_pad(height, width)},
            (0.3, 0.7),
            height_words="R/a",
            width_words="b/a",
            heights=_HEIGHTS[1:],
            checked_heights=(8.0, 16.0),
            is_curved=True,
            is_flat_pad=True,
        ),
    )
}


def kind_named(name: str) -> Kind:
    """The kind of bodies by the name of its map; for an unknown name InputError with the known
    ones.
    """
    if name not in KINDS:
        raise InputError(f"map {name!r}: there is none; known: {', '.join(KINDS)}, or all")
    return KINDS[name]
