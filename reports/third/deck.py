"""A scene as an input deck: one value, which each dialect writes down in its own words."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.interface import check_supports, meshed_pair
from halfplane_fe.path import stretches
from halfplane_fe.scales import Scales, find_scales, sheared
from halfplane_fe.solve import surface_grading
from meshes import MeshSettings
from reports.third.bodies import DeckBody, deck_body, upper_places
from reports.third.settings import DeckSettings
from scenes import Cylinder, HalfPlane, Scene, Shape, freeze
from scenes.frozen import validated

Array = NDArray[np.float64]

# The touch: this share of the first increment of initial loading is spent on a prescribed approach: friction and load control
# find the faces in contact.
_TOUCH = 0.25
# Increments of the initial loading, over those of a revolution.
_INITIAL_LOADING = 0.25


@dataclass(frozen=True, eq=False)
class Deck:
    """Everything that an input deck says.

    Attributes
    ----------
    scene, settings, scales : the question, how it is cut, and the size of its contact
    lower, upper : the bodies; the upper one is held by a rigid plane whose motion is that of the node `reference`
    time : (n + 1,) instants of the scene's path, the unloaded one first; deck times are counted from that one
    normal_load, tangential_load : (n + 1,) [force per thickness]
    touch_time, touch_approach : duration of the first step, and how far the upper plane comes down in it [time, length]
    slides_along_x : whether the upper plane is free to move along x (it is held where there is no friction to hold it)
    stiffness, stick_slope : of the contact, normal and tangential [stress per length]
    element_size : surface elements at the edges [length]
    """

    scene: Scene
    settings: DeckSettings
    scales: Scales
    lower: DeckBody
    upper: DeckBody
    time: Array
    normal_load: Array
    tangential_load: Array
    touch_time: float
    touch_approach: float
    slides_along_x: bool
    stiffness: float
    stick_slope: float
    element_size: float

    @property
    def reference(self) -> int:
        """Number of the node that the upper rigid plane moves with."""
        return self.upper.first_node + len(self.upper.nodes)

    @property
    def deck_time(self) -> Array:
        """(n + 1,) total time of the deck at the instants."""
        return np.asarray(self.time - self.time[0])

    @property
    def increments(self) -> Array:
        """(n,) durations between instants; the first one less the touch."""
        found = np.diff(self.deck_time)
        found[0] -= self.touch_time
        return np.asarray(found)


def build_deck(scene: Scene, settings: DeckSettings | None = None, scales: Scales | None = None) -> Deck:
    """The deck of a scene.

    Parameters
    ----------
    scales : size of the contact, from an earlier solution; spares the coarse run

    Raises
    ------
    InputError
        For a scene that does not pass its own check, and for bodies that can't be meshed or held, see `meshes.solids` and
        `halfplane_fe.solve`.
    """
    scene, settings = validated(scene, Scene), settings or DeckSettings()
    check_supports(scene, sheared(scene))
    scales = scales or find_scales(scene, Counter())
    cut = MeshSettings(
        element_size=settings.element_size,
        edge_element_size=settings.edge_element_size,
        far_radius=settings.far_radius,
        growth=settings.growth,
        order=1,
        cells="quadrilaterals",
    )
    meshes = meshed_pair(scene, cut, partial(surface_grading, cut, scales))
    lower = deck_body("LOWER", meshes[0], meshes[0].mesh.p, 1, 1)
    profile = None if scene.bodies.faces_are_true else scene.profile
    upper = deck_body("UPPER", meshes[1], upper_places(meshes[1], profile), len(lower.nodes) + 1, len(lower.elements) + 1)
    time = instants(scene, settings)
    normal, tangential = scene.load.path().at(time)
    touch = _TOUCH * (time[1] - time[0])
    element_size = settings.edge_element_size * scales.half_width
    unit = scales.modulus / element_size
    return Deck(
        scene,
        settings,
        scales,
        lower,
        upper,
        freeze(time),
        freeze(normal),
        freeze(tangential),
        float(touch),
        _approach(scene, settings, scales, _TOUCH * float(normal[1])),
        scene.friction.coefficient > 0,
        settings.normal_stiffness * unit,
        settings.stick_stiffness * unit,
        element_size,
    )


def instants(scene: Scene, settings: DeckSettings) -> Array:
    """(n + 1,) the unloaded instant, then the end of every increment: turning points of the path, and even ones between them."""
    path, steps = scene.load.path(), settings.steps_per_cycle
    turns = min(settings.cycles, scene.cycles) if path.period is not None else 0
    pieces = [
        (path.initial_loading, max(_INITIAL_LOADING * steps, 4.0)),
        *((path.cycle_legs(k), float(steps)) for k in range(turns)),
    ]
    found = [path.start]
    for legs, count in pieces:
        duration = legs[-1].end - legs[0].start
        for leg in legs:
            for piece in stretches(leg, scene.friction.coefficient, count * (leg.end - leg.start) / duration):
                found.extend(piece.ends)
    return np.array(found)


def _approach(scene: Scene, settings: DeckSettings, scales: Scales, load: float) -> float:
    """Approach [length] at which bodies this deep carry about `load`: that of a line load on half-planes, 2 P ln(4 L/a)/(pi E*).

    It need not be right: the touch is no instant of the answer, and all that counts is that the faces meet.
    """
    reach = settings.far_radius * scales.half_width
    depth = min(_depth(body, reach) for body in (scene.bodies.lower, scene.bodies.upper))
    return float(2 * load * np.log1p(4 * depth / scales.half_width) / (np.pi * scales.modulus))


def _depth(body: Shape, reach: float) -> float:
    if isinstance(body, HalfPlane):
        return reach
    return body.radius if isinstance(body, Cylinder) else body.height
