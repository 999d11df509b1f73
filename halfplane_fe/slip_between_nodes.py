"""Largest slip of a load cycle, over all places of the contact: between nodes too, and up to its
edges.

Slip grows up to the edge of contact, which lies between two nodes. The range of slip of a node
lacks what is added beyond it, or counts what the node slips after the edge has passed it. So a
place counts as in contact while it lies between both edges. How far it slips between two instants
is read off the nodes on either side of it where both touch, else off the two nodes inside of it.

Random half-planes, seed 701 of `benchmarks/covered.py values`: 1.5e-3 of the largest slip from the
true one in the median on the coarse preset, 1e-4 on the default one; the largest range of a node
1.4e-2 and 4e-3.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from scenes import OPEN
from scenes.array_types import Array, Mask
from scenes.solution import ContactSolution

# Places of an edge between two nodes at which slip is looked at, at most: of long records not all.
_MOST_PLACES = 256
# Share of a distance of nodes by which an edge that stays moves by round-off.
_SAME_EDGE = 1e-6
# Distances of nodes over which the change of slip is a mean: of one alone corners and mid-side
# nodes may agree by chance.
_NODES_INWARDS = 2


class LargestSlip(NamedTuple):
    """The largest range of slip of a place while it is in contact, over a load cycle.

    Attributes
    ----------
    value
        largest minus least slip [length]; 0 where nothing ever touches
    x
        the place [length]; NaN where nothing ever touches
    change_to_nodes
        change of this range per distance of nodes towards the middle [length]: the mean over the
        two nodes inside of the place; from the first of them to the place if it slips less than
        half as far
    """

    value: float
    x: float
    change_to_nodes: float


def largest_slip(solution: ContactSolution) -> LargestSlip:
    """The largest slip of the last cycle of a solution at nodes: the range of slip (largest minus
    least) of any place while it is in contact, with that place.
    """
    rows = solution.last_cycle
    return largest_slip_of_cycle(
        solution.x,
        solution.slip[rows],
        solution.state[rows] != OPEN,
        solution.contact_edges[rows],
    )


def largest_slip_of_cycle(
    x: Array, slip: Array, is_closed: Mask, contact_edges: Array
) -> LargestSlip:
    """The largest slip over k instants, see `largest_slip`.

    It is that of the nodes, and of the places at which an edge of contact is at one of the
    instants. These lie as far out as a place can be that has touched until then.

    Parameters
    ----------
    x
        (n,) nodes in ascending order [length]
    slip, is_closed
        (k, n) slip of the nodes [length], and which of them touch
    contact_edges
        (k, 2) left and right edge of contact [length]; NaN without contact

    Examples
    --------
    Two instants of a contact that ends half-way between two nodes:

    >>> x = np.arange(5.0)
    >>> slip = np.array([[0.0, 0.0, 0.0, 0.0, 9.0], [0.0, 0.0, 1.0, 2.0, 9.0]])
    >>> largest_slip_of_cycle(x, slip, slip < 9, np.array([[0.0, 3.5], [0.0, 3.5]]))
    LargestSlip(value=2.5, x=3.5, change_to_nodes=1.0)
    """
    has_contact = np.isfinite(contact_edges).all(axis=1) & is_closed.any(axis=1)
    if not has_contact.any():
        return LargestSlip(value=0.0, x=math.nan, change_to_nodes=0.0)
    left_edge, right_edge = contact_edges[has_contact].T
    slip, is_closed = slip[has_contact], is_closed[has_contact]
    by_right_edge = _largest_by_right_edge(x, slip, is_closed, (left_edge, right_edge))
    # the left side as its mirror image: nodes in reverse, places and edges with the other sign
    by_left_edge = _largest_by_right_edge(
        -x[::-1], slip[:, ::-1], is_closed[:, ::-1], (-right_edge, -left_edge)
    )
    return max(by_right_edge, by_left_edge._replace(x=-by_left_edge.x))


def _largest_by_right_edge(
    x: Array, slip: Array, is_closed: Mask, edges: tuple[Array, Array]
) -> LargestSlip:
    """The largest slip over k instants at the nodes, and at the places of the right edge of
    contact. `edges` are the left and the right one, (k,) each; else as `largest_slip_of_cycle`.
    """
    left_edge, right_edge = edges

    # Intervals from each node to the next one outwards. What slips in one of them is at most what
    # the inner node does, and what is added from the node before it; or what the outer one does.
    # They are searched in the order of these bounds. One node at a time: records are long.
    bounds = np.zeros(len(x) - 2)
    for number in range(len(x) - 2):
        before, inner, outer = number, number + 1, number + 2
        is_in_contact = (x[inner] >= left_edge) & (x[inner] <= right_edge)
        widening = (x[outer] - x[inner]) / (x[inner] - x[before])
        bound = _range(slip[is_in_contact, inner]) + widening * _range(
            slip[is_in_contact, inner] - slip[is_in_contact, before]
        )
        bounds[number] = max(bound, _range(slip[is_in_contact & is_closed[:, outer], outer]))

    value, place = 0.0, float(np.mean(edges))
    for number in np.argsort(-bounds).tolist():
        if bounds[number] <= value:
            break
        rows = (x[number + 1] >= left_edge) & (x[number + 1] <= right_edge)
        nodes = slice(number, number + 3)  # the one before, the inner and the outer one
        value_of_interval, place_of_interval = _largest_between_nodes(
            x[nodes], slip[rows, nodes], is_closed[rows, number + 2], right_edge[rows]
        )
        if value_of_interval > value:
            value, place = value_of_interval, place_of_interval

    # Range of the nodes inside of the place while that is in contact.
    inner_node = int(np.searchsorted(x, place, side="right")) - 1
    beyond_inner_node = max(inner_node - _NODES_INWARDS, 0)
    same_edge = _SAME_EDGE * (x[inner_node + 1] - x[inner_node])
    rows = (left_edge <= place + same_edge) & (right_edge >= place - same_edge)
    range_of_inner_node = _range(slip[rows, inner_node])
    change_inwards = range_of_inner_node - _range(slip[rows, beyond_inner_node])
    change_to_nodes = abs(change_inwards) / _NODES_INWARDS
    # Where most of the slip is beyond the inner node, the zone is narrower than the next distance.
    change_outwards = value - range_of_inner_node
    if change_outwards > range_of_inner_node:
        change_to_nodes = max(change_to_nodes, change_outwards)
    return LargestSlip(value, place, change_to_nodes)


def _range(values: Array) -> float:
    """Largest minus least of values; 0 of none."""
    return float(np.ptp(values)) if len(values) else 0.0


def _largest_between_nodes(
    x: Array, slip: Array, outer_is_closed: Mask, right_edge: Array
) -> tuple[float, float]:
    """The largest slip over k instants between two neighbouring nodes: at the inner one, and at the
    places of the right edge of contact; with its place.

    Between two instants at which the outer node touches, slip is linear between both nodes. Where
    it does not at one of them, slip goes on at both along the line from the node before the inner
    one.

    Parameters
    ----------
    x
        (3,) node before the inner one, inner and outer node [length]
    slip
        (k, 3) of these nodes [length]
    outer_is_closed
        (k,) whether the outer node touches; the inner one is between the edges at all instants
    right_edge
        (k,) [length]
    """
    before, inner, outer = x
    edges_between = right_edge[(right_edge > inner) & (right_edge < outer)]
    places = np.unique(np.append(edges_between, inner))
    # _MOST_PLACES: 256
    if len(places) > _MOST_PLACES:
        places = places[np.linspace(0, len(places) - 1, _MOST_PLACES).round().astype(int)]
    # (k, n_places); _SAME_EDGE: round-off of an edge over the distance of nodes
    is_in_contact = places <= right_edge[:, None] + _SAME_EDGE * (outer - inner)
    is_between_closed = is_in_contact & outer_is_closed[:, None]
    is_beyond_closed = is_in_contact & ~outer_is_closed[:, None]

    # Slip at these places at each instant, (k, n_places), by either line.
    slip_before, slip_inner, slip_outer = (slip[:, number, None] for number in range(3))
    distances = places - inner
    by_both_nodes = slip_inner + (slip_outer - slip_inner) * distances / (outer - inner)
    by_inner_nodes = slip_inner + (slip_inner - slip_before) * distances / (inner - before)

    # The largest difference of two instants; -infinite where there are none.
    most, least = _extreme_values(by_both_nodes, is_between_closed)
    most_by_inner_nodes, least_by_inner_nodes = _extreme_values(by_inner_nodes, is_in_contact)
    most_beyond, least_beyond = _extreme_values(by_inner_nodes, is_beyond_closed)
    slip_ranges = np.maximum.reduce(
        [most - least, most_by_inner_nodes - least_beyond, most_beyond - least_by_inner_nodes]
    )
    number = int(np.argmax(slip_ranges))
    return float(slip_ranges[number]), float(places[number])


def _extreme_values(values: Array, is_chosen: Mask) -> tuple[Array, Array]:
    """Largest and least of values (k, n) over those rows that are chosen, (n,) each; -infinite and
    infinite where none is.
    """
    return (
        np.max(values, axis=0, where=is_chosen, initial=-np.inf),
        np.min(values, axis=0, where=is_chosen, initial=np.inf),
    )
