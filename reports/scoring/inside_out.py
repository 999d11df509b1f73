"""Elements of somebody else's mesh that are turned inside out: corners at which the Jacobian has the wrong sign."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from reports.scoring.surface_nodes import SAME, body_of, extent

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Over the product of the edges at the corner; below it a corner is flat, and has no sense.
_FLAT = 1e-6
# For each corner the neighbours along its edges, right-handed in a sound element.
_EDGES: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": ((1, 2), (2, 0), (0, 1)),
    "quad": ((1, 3), (2, 0), (3, 1), (0, 2)),
    "tetra": ((1, 2, 3), (2, 0, 3), (0, 1, 3), (0, 2, 1)),
    "wedge": ((1, 2, 3), (2, 0, 4), (0, 1, 5), (5, 4, 0), (3, 5, 1), (4, 3, 2)),
    "hexahedron": ((1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)),
}


def inside_out(points: Array, cells: Iterable[tuple[str, Integers]]) -> list[str]:
    """A sentence where elements have a corner of the other sense than most of their body: such a mesh has no right answer.

    A body whose elements are all counted the other way round is no fault: codes differ in that. Only corners are looked at, not the
    nodes between them. Plane elements count where the model is plane: as the surface of a thick one they look either way.

    Parameters
    ----------
    points : (n_points, 3) [length]
    cells : kind as meshio calls it ("quad", "quad8", ...), and rows of points, (n_cells, n_nodes), corners first

    >>> points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]])
    >>> inside_out(points, [("quad", np.array([[0, 1, 4, 3], [1, 2, 5, 4]]))])
    []
    """
    known = [(_EDGES.get(kind.rstrip("0123456789"), ()), rows) for kind, rows in cells]
    solid = [(edges, rows[:, : len(edges)]) for edges, rows in known if len(rows) and 0 < len(edges) <= rows.shape[1]]
    if np.ptp(points[:, 2]) > SAME * extent(points):
        solid = [(edges, rows) for edges, rows in solid if len(edges[0]) == 3]
    if not solid:
        return []
    senses = [_senses(points, edges, rows) for edges, rows in solid]
    bodies = body_of(len(points), [rows for _, rows in solid])
    body = np.concatenate([bodies[rows[:, 0]] for _, rows in solid])
    least, most = (np.concatenate([np.asarray(of(sense, axis=1)) for sense in senses]) for of in (np.min, np.max))
    usual = np.where(np.bincount(body, weights=least + most)[body] < 0, -1, 1)
    wrong = np.flatnonzero((least < 0) & (usual > 0) | (most > 0) & (usual < 0))
    if not len(wrong):
        return []
    middles = np.concatenate([points[rows].mean(axis=1) for _, rows in solid])
    x, y = middles[wrong[0], :2]
    count = "1 element is" if len(wrong) == 1 else f"{len(wrong)} elements are"
    return [
        f"{count} turned inside out, of {len(body)} (a corner with a negative Jacobian; the first lies around x = {x:.4g}, "
        f"y = {y:.4g}): the mesh is broken there, and what was computed on it can't be trusted; it is scored as it is"
    ]


def _senses(points: Array, edges: tuple[tuple[int, ...], ...], rows: Integers) -> NDArray[np.int64]:
    """(n_cells, n_corners): 1 right-handed, -1 left-handed, 0 flat."""
    found = []
    for corner, neighbours in enumerate(edges):
        along = [points[rows[:, k]] - points[rows[:, corner]] for k in neighbours]
        normal = np.cross(along[0], along[1])
        volume = normal[:, 2] if len(along) == 2 else np.sum(normal * along[2], axis=1)
        size = np.prod([np.linalg.norm(edge, axis=1) for edge in along], axis=0)
        found.append(np.where(np.abs(volume) <= _FLAT * size, 0, np.sign(volume)).astype(np.int64))
    return np.column_stack(found)
