"""Which nodes of somebody else's mesh are points of the contact surface: body below or above, one plane of a thick model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

SAME = 1e-6  # places that differ by less than this share of the mesh's extent are one: text files carry six digits


@dataclass(frozen=True, eq=False)
class Plane:
    """Points of one plane z = const, ascending in x.

    Attributes
    ----------
    rows : (n_points,), which of the points given
    x : (n_points,) [length]
    depth : from the first to the last plane [length]; 0 for a plane model
    notes : that a plane was chosen, where there are several
    """

    rows: Integers
    x: Array
    depth: float
    notes: tuple[str, ...]


def one_plane(points: Array, chosen: Integers) -> Plane:
    """Of the `chosen` rows of `points` (n, 3) those with one z: the plane that holds most of them, the lowest where several do.

    >>> thick = np.array([[1.0, 0, 0], [0.0, 0, 0], [0.0, 0, 1.0], [1.0, 0, 1.0]])
    >>> plane = one_plane(thick, np.arange(4))
    >>> plane.rows.tolist(), plane.notes
    ([1, 0], ('the model is 1 thick: the tractions are those of its plane z = 0, one of 2',))
    """
    depth = points[chosen, 2]
    levels, members = _levels(depth, SAME * extent(points))
    counts = np.bincount(members, minlength=len(levels))
    taken = int(np.argmax(counts))
    rows = chosen[members == taken]
    rows = rows[np.argsort(points[rows, 0], kind="stable")]
    notes: tuple[str, ...] = ()
    if len(levels) > 1:
        notes = (
            f"the model is {np.ptp(depth):.6g} thick: the tractions are those of its plane z = {levels[taken]:.6g}, "
            f"one of {len(levels)}",
        )
    return Plane(rows, points[rows, 0], float(np.ptp(depth)) if len(levels) > 1 else 0.0, notes)


def extent(points: Array) -> float:
    """The longest side of the box around the points [length]."""
    return float(np.max(np.ptp(points, axis=0))) if len(points) else 0.0


def _levels(values: Array, tolerance: float) -> tuple[Array, Integers]:
    """Values that differ by more than the tolerance, and which of them each value is."""
    order = np.argsort(values, kind="stable")
    jumps = np.concatenate([[0], np.cumsum(np.diff(values[order]) > tolerance)])
    members = np.empty(len(values), np.int64)
    members[order] = jumps
    return np.array([values[members == k].min() for k in range(int(jumps[-1]) + 1)]), members


def material_above(points: Array, cells: Sequence[Integers]) -> Array:
    """(n_points,): how far the middles of a point's cells lie above it in the mean [length]; NaN for a point that is in no cell.

    Negative at the top face of the lower body, positive at the bottom face of the upper one.

    Parameters
    ----------
    points : (n_points, 3)
    cells : rows of points of each cell, (n_cells, n_corners), a block for each kind
    """
    total, count = np.zeros(len(points)), np.zeros(len(points))
    for block in cells:
        middle = points[block, 1].mean(axis=1)
        np.add.at(total, block, middle[:, None] - points[block, 1])
        np.add.at(count, block, 1.0)
    return np.divide(total, count, out=np.full(len(points), np.nan), where=count > 0)


def body_of(n_points: int, cells: Sequence[Integers]) -> Integers:
    """(n_points,): number of the connected body that a point is part of."""
    tails = [np.repeat(block[:, :1], block.shape[1], axis=1).ravel() for block in cells]
    heads = [block.ravel() for block in cells]
    rows, columns = (np.concatenate([np.empty(0, np.int64), *parts]) for parts in (tails, heads))
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(n_points, n_points))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)
