"""Where the permanent stick zone ends, by the friction work of the nodes.

What sticks all through a cycle does no friction work. So the zone ends a little before the first
node, outwards, that does some: a reading of its own beside the stick edges of single instants, of
which one that is wrong is enough to make the zone too small.

Edges are (2,), left and right; W(x) and x are (n,), x ascending.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from scenes.array_types import Array, Mask

# Friction work of a node, over the largest one, from which on it counts as work.
_WORKS = 1e-6
# Distances of nodes from the edge outwards to the first node that works: 0.1 to 1.25 on seed 201 of
# benchmarks/covered.py values, both presets; and their mean.
_FARTHEST = 1.3
_MEAN = 0.66
# The same that may lie between this reading and the edge of the stick zones, if both speak of one
# edge.
_SAME_EDGE = 4.0
# Uncertainty of an edge that both readings agree on, in distances of nodes: 0.48 at most on the
# default mesh, 0.68 on the coarse one.
_SHARE = 0.65


class WorkingNodes(NamedTuple):
    """The first nodes that do friction work outwards of a permanent stick zone.

    Attributes
    ----------
    places
        (2,) of these nodes [length]; NaN where none is near the edge
    spacing
        (2,) distance from the idle node before [length]
    """

    places: Array
    spacing: Array

    def before(self, edges: Array) -> Mask:
        """(2,) whether an edge lies a little before the first node that works."""
        outwards = np.array([-1.0, 1.0])
        distance = (self.places - edges) * outwards
        return np.asarray((distance >= 0) & (distance <= _FARTHEST * self.spacing))

    def confine(self, edges: Array) -> Array:
        """The edges, each where it cannot be replaced by the mean place before the first node that
        works.

        >>> nodes = WorkingNodes(np.array([-2.0, 2.0]), np.array([0.5, 0.5]))
        >>> nodes.confine(np.array([-1.8, 1.0])).tolist()
        [-1.8, 1.67]
        """
        outwards = np.array([-1.0, 1.0])
        mean_places = self.places - outwards * _MEAN * self.spacing
        misread = np.isfinite(self.places) & ~self.before(edges)
        return np.where(misread, mean_places, edges)

    def uncertainty(self, edges: Array, by_stick_zones: Array) -> Array:
        """(2,) of edges [length]: by the stick zones of the instants, and no more than what the
        friction work of the nodes leaves open.
        """
        is_confined = self.before(edges)
        return np.where(
            is_confined, np.minimum(by_stick_zones, _SHARE * self.spacing), by_stick_zones
        )


def working_nodes(x: Array, density: Array, edges: Array) -> WorkingNodes:
    """The first node on either side of a zone between two `edges` (2,) that does friction work, by
    `density` (n,), W(x) of the cycle in any unit; NaN where none is near the edge.
    """
    does_work = density > _WORKS * np.max(density, initial=0.0)
    middle = np.mean(edges)
    places = np.full(2, np.nan)
    spacing = np.full(2, np.nan)
    for side, outwards in enumerate((-1, 1)):
        nodes_beyond = np.flatnonzero(does_work & ((x - middle) * outwards > 0))
        if not len(nodes_beyond):
            continue
        first_node = nodes_beyond[0] if outwards > 0 else nodes_beyond[-1]
        node_spacing = abs(x[first_node] - x[first_node - outwards])
        if abs(x[first_node] - edges[side]) <= _SAME_EDGE * node_spacing:
            places[side] = x[first_node]
            spacing[side] = node_spacing
    return WorkingNodes(places, spacing)
