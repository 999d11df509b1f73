"""The two bodies of a deck: nodes, plane-strain quadrilaterals, the contact face and what holds them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from meshes import BodyMesh
from scenes import Profile, freeze

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Directions in which a boundary of that support can't move against the rigid plane behind it.
_HELD = {"fixed": (1, 2), "half_plane": (1, 2), "rollers": (2,), "guided": (1,)}


@dataclass(frozen=True, eq=False)
class DeckBody:
    """One body in the common frame, y out of the lower one; numbers as in the deck, from `first_node` and `first_element` on.

    Attributes
    ----------
    name : "LOWER" or "UPPER"
    nodes : (n, 2) places [length]
    elements : (m, 4) node numbers, anticlockwise
    contact_faces : (k, 2) element number and face 1-4, from the nodes (1, 2), (2, 3), (3, 4), (4, 1)
    contact_nodes : (k + 1,) node numbers by ascending x
    held : direction 1 or 2 -> node numbers that move as the rigid plane does
    """

    name: str
    first_node: int
    first_element: int
    nodes: Array
    elements: Indices
    contact_faces: Indices
    contact_nodes: Indices
    held: Mapping[int, Indices]

    def areas(self) -> Array:
        """(m,) areas of the elements, positive where they go round anticlockwise [length^2]."""
        x, y = self.nodes[self.elements - self.first_node].transpose(2, 0, 1)
        return np.asarray((x * (np.roll(y, -1, 1) - np.roll(y, 1, 1))).sum(1) / 2)


def deck_body(name: str, mesh: BodyMesh, places: Array, first_node: int, first_element: int) -> DeckBody:
    """The body of a mesh whose nodes are moved to `places` (2, n)."""
    cells = _anticlockwise(mesh.mesh.t, places)
    faces = _faces(mesh, "contact", cells)
    ends = np.unique(np.concatenate([cells[faces[:, 1], faces[:, 0]], cells[(faces[:, 1] + 1) % 4, faces[:, 0]]]))
    return DeckBody(
        name,
        first_node,
        first_element,
        freeze(places.T),
        freeze(cells.T + first_node, np.int64),
        freeze(faces + np.array([first_element, 1]), np.int64),
        freeze(ends[np.argsort(places[0, ends])] + first_node, np.int64),
        {direction: freeze(nodes + first_node, np.int64) for direction, nodes in _held(mesh).items()},
    )


def _anticlockwise(cells: Indices, places: Array) -> Indices:
    x, y = places[:, cells]
    clockwise = (x * (np.roll(y, -1, 0) - np.roll(y, 1, 0))).sum(0) < 0
    turned = cells.copy()
    turned[:, clockwise] = cells[:, clockwise][[0, 3, 2, 1]]
    return turned


def _faces(mesh: BodyMesh, boundary: str, cells: Indices) -> Indices:
    """(k, 2) element and side, both from 0, of the elements' sides on a boundary."""
    wanted = {tuple(sorted(pair)) for pair in mesh.mesh.facets[:, mesh.mesh.boundaries[boundary]].T.tolist()}
    elements = np.unique(mesh.mesh.f2t[0, mesh.mesh.boundaries[boundary]])
    found = [
        (element, side)
        for element in elements.tolist()
        for side in range(4)
        if tuple(sorted((int(cells[side, element]), int(cells[(side + 1) % 4, element])))) in wanted
    ]
    return np.array(found, np.int64)


def _held(mesh: BodyMesh) -> dict[int, Indices]:
    held: dict[int, list[Indices]] = {1: [], 2: []}
    for boundary, support in mesh.supports.items():
        nodes = np.unique(mesh.mesh.facets[:, mesh.mesh.boundaries[boundary]])
        for direction in _HELD[support]:
            held[direction].append(nodes)
        if support == "rollers" and "guided" not in mesh.supports.values():
            # Nothing else keeps the body from drifting along x; without a tangential load this support carries nothing.
            held[1].append(nodes[[np.argmin(np.abs(mesh.mesh.p[0, nodes]))]])
    return {direction: np.unique(np.concatenate(nodes)) for direction, nodes in held.items() if nodes}


def upper_places(mesh: BodyMesh, profile: Profile | None) -> Array:
    """(2, n) nodes of an upper body, which its mesh has upside down, in the common frame.

    Parameters
    ----------
    profile : the gap, where the face is flat and the gap has to be cut into it: h(x) at the face, going down to nothing at the
        far end of the body; None for a face that is true as it is. Beyond the side that may touch, h(x) goes on as
        h + h' c tanh((|x| - c)/c), c the end of that side: smooth, and bounded on a body of any width
    """
    x, y = mesh.mesh.p[0], -mesh.mesh.p[1]
    if profile is None:
        return np.stack([x, y])
    return np.stack([x, y + gap_beyond(profile, mesh.grading.outer, x) * (1 - y / y.max())])


def gap_beyond(profile: Profile, end: float, x: Array) -> Array:
    """h(x) for |x| <= end, and its bounded continuation [length]; any shape."""
    distance, step = np.abs(x), 1e-4 * end
    before, at = (float(profile.height(np.array(end - part))) for part in (step, 0.0))
    slope = (at - before) / step
    inside = np.asarray(profile.height(np.minimum(distance, end)))
    return inside + slope * end * np.tanh(np.maximum(distance - end, 0.0) / end)
