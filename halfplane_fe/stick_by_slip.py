"""Ends of the permanent stick zone by how far the nodes beyond them slip in a cycle.

The states of nodes tell an end to half the distance of two nodes. Slip tells more. Where a stick
edge at e comes inwards by de, a point outside it slips by an amount that grows as sqrt(x - e) de.
Beyond the innermost place c of the edge the range of slip then grows as (x - c)^(3/2). The power
2/3 of the range is a straight line that is zero at c. It is so between unlike bodies, and under
bulk stress and tilt.

# notation: c end of the permanent stick zone
"""

from __future__ import annotations

import numpy as np

from halfplane_fe.edges import Edges
from scenes.array_types import Array

# Power of the range of slip that is a straight line.
_POWER = 2 / 3
# Nodes that a line takes; the second one beyond the zone is the first of them. Lines that begin one
# node before and after it tell how straight the power is.
_ON_LINE = 3
_LINES = 3
# Shares of how far the zeros of these two differ, and of the distance of two nodes, that the end is
# uncertain by. Real bodies, seeds 301 to 303 of benchmarks/covered.py bodies, coarse.
_BY_LINES = 0.6
_BY_SPACING = 0.08
# Distances of nodes from the end by the states of nodes beyond which a zero is no end.
_SAME_END = 2.0


def ends_by_slip(x: Array, slip_range: Array, ends_by_states: Array) -> Edges:
    """Left and right end (2,) of the permanent stick zone, and the uncertainty of each; NaN where
    the range of slip does not tell [length].

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
    >>> x = np.arange(-9.0, 10.0)
    >>> beyond = np.maximum(np.abs(x) - 3.2, 0.0)
    >>> ends_by_slip(x, beyond**1.5, np.array([-3.5, 3.5])).places.round(9).tolist()
    [-3.2, 3.2]
    """
    places = np.full(2, np.nan)
    uncertainty = np.full(2, np.nan)
    if np.isnan(ends_by_states).any():
        return Edges(places, uncertainty)
    for column, side in enumerate((-1, 1)):
        next_right = int(np.searchsorted(x, ends_by_states[column]))
        first_sliding = next_right if side > 0 else next_right - 1
        nodes = first_sliding + side * np.arange(_ON_LINE + _LINES - 1)
        if nodes.min() < 1 or nodes.max() > len(x) - 2:
            continue
        powers = slip_range[nodes] ** _POWER
        zeros = [
            _zero(x[nodes[start : start + _ON_LINE]], powers[start : start + _ON_LINE])
            for start in range(_LINES)
        ]
        first_zero, place, last_zero = zeros
        spacing = abs(x[first_sliding] - x[first_sliding - side])
        # False of NaN too
        if abs(place - ends_by_states[column]) <= _SAME_END * spacing:
            places[column] = place
            misfit = abs(last_zero - first_zero)
            uncertainty[column] = _BY_LINES * misfit + _BY_SPACING * spacing
    return Edges(places, uncertainty)


def _zero(x: Array, values: Array) -> float:
    """Zero of the straight line of least squares through values at x; NaN of a level line."""
    from_mean = x - x.mean()
    slope = float(from_mean @ values / (from_mean @ from_mean))
    return float(x.mean() - values.mean() / slope) if slope else float("nan")
