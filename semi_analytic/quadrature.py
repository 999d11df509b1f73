"""Quadrature rules: Gauss' for smooth integrands, and one for singularities that lie at the ends of
the range or close to them.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from scenes.array_types import Array

_STEP_OF_LOGISTIC_RULE = 0.375


class LogisticRule(NamedTuple):
    """Quadrature rule on [0, 1]: the trapezoidal rule in s, for nodes 1/(1 + exp(-s)).

    Attributes
    ----------
    distance_from_begin, distance_from_end
        distances of the nodes from 0 and from 1, (n,) each, without cancellation
    weight
        of each node, (n,)
    """

    distance_from_begin: Array
    distance_from_end: Array
    weight: Array


def logistic_rule(
    first_s: float, last_s: float, step: float = _STEP_OF_LOGISTIC_RULE
) -> LogisticRule:
    """The trapezoidal rule from s = `first_s` to s = `last_s` in equal steps, for nodes 1/(1 +
    exp(-s)) on [0, 1]: distances of the nodes from 0 and from 1, and weights.
    """
    s = np.arange(first_s, last_s + step / 2, step)
    distance_from_begin = 1 / (1 + np.exp(-s))
    distance_from_end = 1 / (1 + np.exp(s))
    distance_from_nearer_end = np.minimum(distance_from_begin, distance_from_end)
    return LogisticRule(
        distance_from_begin,
        distance_from_end,
        step * distance_from_nearer_end * (1 - distance_from_nearer_end),
    )


GRADED_RULE = logistic_rule(-36.0, 36.0)
"""For square roots and logarithms at the ends: what lies beyond the outermost nodes, 2e-16 of the
range, is left out.
"""

RULE_FOR_INVERSE_ROOTS = logistic_rule(-75.0, 75.0)
"""For an inverse square root at either end too: its integral over what is left out there, 3e-33 of
the range, is 1e-16.
"""

GRADED_NODE_COUNT = len(GRADED_RULE.distance_from_begin)
"""Nodes of `graded_nodes`."""

_IN_LOWER_HALF = GRADED_RULE.distance_from_begin < 0.5
_DISTANCE_FROM_NEARER_END = np.minimum(
    GRADED_RULE.distance_from_begin, GRADED_RULE.distance_from_end
)


def graded_nodes(begin: ArrayLike, end: ArrayLike, stride: int = 1) -> tuple[Array, Array]:
    """Quadrature nodes and weights on [begin, end], a new last axis, for integrands singular at or
    next to the ends: the trapezoidal rule in s, for nodes begin + (end - begin)/(1 + exp(-s)).

    A singularity beyond an end lies on the line Im s = pi, however near the end it is. Square roots
    and logarithms there cost no digits: the error is about 1e-14 of the largest value times the
    range. With a `stride` of 2 every second node is taken, which halves the number of digits.
    GRADED_RULE is that rule on [0, 1]; here its nodes are taken as distances from the nearer end.

    >>> nodes, weights = graded_nodes(0.0, 4.0)
    >>> round(float(np.sum(weights * np.sqrt(nodes))), 12)  # 2/3 4^(3/2)
    5.333333333333
    """
    begin_column = np.asarray(begin, dtype=float)[..., None]
    end_column = np.asarray(end, dtype=float)[..., None]
    range_length = end_column - begin_column
    distance_from_nearer_end = range_length * _DISTANCE_FROM_NEARER_END[::stride]
    nodes = np.where(
        _IN_LOWER_HALF[::stride],
        begin_column + distance_from_nearer_end,
        end_column - distance_from_nearer_end,
    )
    return nodes, range_length * (stride * GRADED_RULE.weight[::stride])


@cache
def gauss_rule(n_nodes: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss' quadrature rule on [0, 1], (n_nodes,) each, read-only: exact for
    polynomials up to degree 2 n_nodes - 1.

    >>> nodes, weights = gauss_rule(3)
    >>> round(float(np.sum(weights * nodes**5)), 15)
    0.166666666666667
    """
    # on [-1, 1]
    legendre_nodes, legendre_weights = np.polynomial.legendre.leggauss(n_nodes)
    rule = (1 + legendre_nodes) / 2, legendre_weights / 2
    for nodes_or_weights in rule:
        nodes_or_weights.flags.writeable = False
    return rule


def crowded_nodes(begin: ArrayLike, end: ArrayLike) -> tuple[Array, Array]:
    """Quadrature nodes and weights on [begin, end], a new last axis, for integrands with square
    roots at the ends.

    It is Gauss' rule of 24 nodes in t, for nodes begin + (end - begin) (3 t^2 - 2 t^3). The nodes
    crowd to both ends; they are an eighth of those of `graded_nodes`. The rule is for ranges that
    are halved until the integral has converged.

    >>> nodes, weights = crowded_nodes(0.0, 4.0)
    >>> round(float(np.sum(weights * np.sqrt(nodes))), 12)  # 2/3 4^(3/2)
    5.333333333333
    """
    # nodes t and weights on [0, 1]
    t, weights = gauss_rule(24)
    begin_column = np.asarray(begin, dtype=float)[..., None]
    range_column = np.asarray(end, dtype=float)[..., None] - begin_column
    return begin_column + range_column * (t * t * (3 - 2 * t)), range_column * (
        weights * 6 * t * (1 - t)
    )


class PanelNodes(NamedTuple):
    """Quadrature nodes of a range that is cut into panels, (..., panels, nodes) each.

    Attributes
    ----------
    place
        of each node
    distance_from_begin, distance_from_end
        distance of each node from the begin and from the end of the range, without cancellation
    weight
        of each node
    """

    place: Array
    distance_from_begin: Array
    distance_from_end: Array
    weight: Array


def panel_nodes(
    begin: ArrayLike, end: ArrayLike, cut_places: Iterable[ArrayLike] = ()
) -> PanelNodes:
    """Quadrature nodes and weights on [begin, end], (..., panels, nodes), for integrands singular
    at both ends and at `cut_places`.

    The range is cut into panels at the `cut_places`, which ascend, each an array like `end`. A
    place outside of all ranges makes no panel; one outside of a single range makes a panel without
    length there. Each node comes with its distances from both ends of the range, free of
    cancellation. GRADED_RULE holds the nodes of a panel on [0, 1] and their weights.
    """
    begin_places, end_places = np.broadcast_arrays(
        np.asarray(begin, dtype=float), np.asarray(end, dtype=float)
    )
    inner_cut_places = [
        place for place in cut_places if np.any((begin_places < place) & (place < end_places))
    ]
    panel_ends = [
        begin_places,
        *(np.clip(place, begin_places, end_places) for place in inner_cut_places),
        end_places,
    ]
    panel_begin = np.stack(panel_ends[:-1], axis=-1)[..., None]
    panel_end = np.stack(panel_ends[1:], axis=-1)[..., None]
    panel_length = panel_end - panel_begin
    distance_from_panel_begin = panel_length * GRADED_RULE.distance_from_begin
    distance_from_panel_end = panel_length * GRADED_RULE.distance_from_end
    distance_from_begin = (panel_begin - begin_places[..., None, None]) + distance_from_panel_begin
    distance_from_end = (end_places[..., None, None] - panel_end) + distance_from_panel_end
    places = np.where(
        _IN_LOWER_HALF, panel_begin + distance_from_panel_begin, panel_end - distance_from_panel_end
    )
    return PanelNodes(
        places, distance_from_begin, distance_from_end, panel_length * GRADED_RULE.weight
    )
