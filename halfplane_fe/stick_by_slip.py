"""Ends of the permanent stick zone by how far the nodes beyond them slip in a cycle.

The states of nodes locate an end to half the distance of two nodes, slip more closely. If a stick
edge at e comes inwards by de, a point outside it slips by an amount that grows as sqrt(x - e) de.
Beyond the innermost place c of the edge the range of slip then grows as (x - c)^(3/2) at first. In
the contact of Cattaneo and Mindlin, whose zone is |x| < c, it is in proportion to

    F(t) = t sqrt(t^2 - 1) - arcosh t,    t = |x|/c.

Other zones have this form too, as far as a few nodes. The power 2/3 of the range, over that of
F(t)/(t - 1)^(3/2), is a straight line that is zero at c. It is so between unlike bodies, and under
bulk stress and tilt.

# notation: c end of the permanent stick zone, from its middle
"""

from __future__ import annotations

import numpy as np

from halfplane_fe.edges import Edges
from scenes.array_types import Array

# Exponent to which the range of slip is raised: the result is a straight line in x.
_EXPONENT = 2 / 3
# Nodes that a line takes; the third one beyond the zone is the first of them: the mesh spoils the
# slip of the first ones. Lines that begin one node before and after it show how straight it is.
_ON_LINE = 3
_FIRST_NODES = (1, 2, 3)
# Times that the line is fitted again with c the zero of the line before: the place then stays to
# 1e-4 of the distance of two nodes.
_ROUNDS = 8
# Shares of how far the zeros of the first and the last line differ, and of the distance of two
# nodes, that the end is uncertain by. It errs by 0.013 of the latter in the median and by 0.06 at
# most: real bodies, seeds 284 and 285 of benchmarks/covered.py bodies, coarse.
_BY_LINES = 0.6
_BY_SPACING = 0.04
# Distances of nodes from the end by the states of nodes beyond which a zero is no end.
_SAME_END = 2.0


def ends_by_slip(x: Array, slip_range: Array, ends_by_states: Array) -> Edges:
    """Left and right end (2,) of the permanent stick zone of a load cycle, by how far the nodes
    beyond them slip, and the uncertainty of each [length]. NaN where the range of slip does not
    grow as it does near an end.

    Beyond an end, at a distance d, the range of slip of a node grows as d^(3/2). So a straight line
    through its power 2/3 at three nodes is zero at the end. Three lines are drawn, from the second,
    third and fourth node beyond the zone on. The middle one gives the end; the uncertainty is a
    share of how far the first and the last differ, and of the distance of two nodes.

    Parameters
    ----------
    x
        (n,) nodes in ascending order [length]
    slip_range
        (n,) range of slip in the last cycle; NaN of nodes that open in it
    ends_by_states
        (2,) half-way between the last node that sticks and the first one that slides; NaN without a
        zone [length]

    Examples
    --------
    >>> x = np.arange(-12.0, 13.0)
    >>> t = np.maximum(np.abs(x) / 3.2, 1.0)
    >>> slip_range = t * np.sqrt(t**2 - 1) - np.arccosh(t)
    >>> ends_by_slip(x, slip_range, np.array([-3.5, 3.5])).places.round(3).tolist()
    [-3.2, 3.2]
    """
    places = np.full(2, np.nan)
    uncertainty = np.full(2, np.nan)
    if np.isnan(ends_by_states).any():
        return Edges(places, uncertainty)
    middle = ends_by_states.mean()
    for column, side in enumerate((-1, 1)):  # left and right end
        # Nodes beyond the end, outwards from the first one that slides.
        next_node_on_right = int(np.searchsorted(x, ends_by_states[column]))
        first_sliding_node = next_node_on_right if side > 0 else next_node_on_right - 1
        # _FIRST_NODES: positions 1, 2 and 3 at which the lines begin; _ON_LINE: three nodes of each
        nodes_beyond = first_sliding_node + side * np.arange(_FIRST_NODES[-1] + _ON_LINE)
        if nodes_beyond.min() < 1 or nodes_beyond.max() > len(x) - 2:
            continue

        # Distance of the end from the middle by each of three lines.
        distances = side * (x[nodes_beyond] - middle)
        ends_by_lines = [
            _end_of_zone(
                distances[first_position : first_position + _ON_LINE],
                slip_range[nodes_beyond][first_position:][:_ON_LINE],
            )
            for first_position in _FIRST_NODES
        ]
        end_by_first_line, end_by_second_line, end_by_last_line = ends_by_lines
        place = middle + side * end_by_second_line
        spacing = abs(x[first_sliding_node] - x[first_sliding_node - side])

        # It is accepted within two node distances of the end by states; NaN is not.
        if abs(place - ends_by_states[column]) <= _SAME_END * spacing:
            places[column] = place
            difference_of_lines = abs(end_by_last_line - end_by_first_line)
            # _BY_LINES: fitted shares
            uncertainty[column] = _BY_LINES * difference_of_lines + _BY_SPACING * spacing
    return Edges(places, uncertainty)


def _end_of_zone(distances: Array, slip_range: Array) -> float:
    """Distance c of the end of a permanent stick zone from its middle, by the range of slip at
    nodes farther out; NaN where that range does not have the form of F [length].

        F(t) = t sqrt(t^2 - 1) - arcosh t,   t = |x|/c   (Cattaneo and Mindlin)

    F(t)/(t - 1)^(3/2) varies little near t = 1. The range over it, raised to the power 2/3, is a
    straight line in x that is zero at c. As t contains c, it is iterated: the range is divided with
    the last c, the line is fitted again, and its zero is the next c, eight times. The first line is
    fitted to the range to the power 2/3 alone.

    Parameters
    ----------
    distances
        (n,) of the nodes from the middle, ascending [length]
    slip_range
        (n,) range of slip of these nodes in a load cycle [length]
    """
    end = _place_of_zero(distances, slip_range**_EXPONENT)
    for _ in range(_ROUNDS):
        if not 0 < end < distances[0]:
            return float("nan")
        t = distances / end
        form_ratio = (t * np.sqrt(t**2 - 1) - np.arccosh(t)) / (t - 1) ** (1 / _EXPONENT)
        end = _place_of_zero(distances, (slip_range / form_ratio) ** _EXPONENT)
    return end


def _place_of_zero(x: Array, values: Array) -> float:
    """Place at which the straight line of least squares through values at places x is zero; NaN of
    a level line.
    """
    distance_from_mean = x - x.mean()
    slope = float(distance_from_mean @ values / (distance_from_mean @ distance_from_mean))
    return float(x.mean() - values.mean() / slope) if slope else float("nan")
