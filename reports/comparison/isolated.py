"""Single values of a result that none of their neighbours supports: a mistyped cell, a node that is
wrong.

# notation: p_ref largest value of a field of the reference
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reports.comparison.cycles import Cycle
from scenes import read_only_copy
from scenes.array_types import Array

Mask = NDArray[np.bool_]

# A spike is 5 times as large as its neighbours in x and in time, and 3 times as large as all other
# values of its field: a traction may be singular at an edge, but not at one point of one instant
# alone.
_FACTOR_OVER_NEIGHBOURS = 5.0
_FACTOR_OVER_FIELD = 3.0
# A spike can be told from a small contact only where more points than these have a value at its
# instant.
_FEWEST_POINTS = 6
# A difference from the reference is isolated if it is 5 times as large as all others and at least a
# tenth of p_ref: noise has large differences by chance.
_FACTOR_OVER_DIFFERENCES = 5.0
_LEAST_SHARE_OF_DIFFERENCE = 0.1
# Point spacings to each side of an edge of contact or stick in which one node alone may be wrong,
# since the edge lies within an element.
_SPACINGS_NEAR_EDGE = 2.0


def spike_mask(values: Array) -> Mask:
    """Where single values of a field are far larger than all others: (n_instants, n_points) -> mask
    of the same shape.

    >>> field = np.full((1, 9), 2.0)
    >>> field[0, 4] = 900.0
    >>> np.flatnonzero(spike_mask(field)[0]).tolist()
    [4]
    """
    return _is_far_larger(values, _FACTOR_OVER_FIELD) & _has_enough_points(values)


def _is_far_larger(values: Array, factor: float) -> Mask:
    """(k instants, n points) whether a value of a field is far larger than the others: a local
    peak, more than 5 times its neighbours in x and in time, and more than `factor` times every
    value that is no local peak. NaN counts as 0.
    """
    sizes = np.abs(np.nan_to_num(values))
    padded_sizes = np.pad(sizes, 1)
    value_at_left_point = padded_sizes[1:-1, :-2]
    value_at_right_point = padded_sizes[1:-1, 2:]
    value_at_instant_before = padded_sizes[:-2, 1:-1]
    value_at_instant_after = padded_sizes[2:, 1:-1]
    largest_neighbour = np.maximum.reduce(
        [value_at_left_point, value_at_right_point, value_at_instant_before, value_at_instant_after]
    )
    is_local_peak = (sizes > 0) & (sizes > _FACTOR_OVER_NEIGHBOURS * largest_neighbour)
    largest_other_size = float(np.max(sizes, where=~is_local_peak, initial=0.0))
    return np.asarray(is_local_peak & (sizes > factor * largest_other_size))


def _has_enough_points(values: Array) -> Mask:
    """(n_instants, 1) whether more than six points have a value other than 0 at an instant."""
    n_points = np.sum(np.nan_to_num(values) != 0, axis=1, keepdims=True)
    return np.asarray(n_points > _FEWEST_POINTS)


def without_spikes(values: Array) -> Array:
    """A field of values (n_instants, n_points) without its spikes, single values that are far
    larger than the others of the instant: each is replaced by the mean of its neighbours in x.
    The same array where there is none, else a read-only copy.
    """
    is_spike = spike_mask(values)
    if not is_spike.any():
        return values
    smooth_values = values.copy()
    # indices of the instant and the point of each spike
    for instant, point in np.argwhere(is_spike):
        neighbours = [
            neighbour for neighbour in (point - 1, point + 1) if 0 <= neighbour < values.shape[1]
        ]
        smooth_values[instant, point] = np.mean(values[instant, neighbours])
    return read_only_copy(smooth_values)


def masks_of_isolated_values(result_cycle: Cycle, reference_cycle: Cycle) -> dict[str, Mask]:
    """Isolated values in the last cycle of a result, which no neighbour supports: masks (k
    instants, n points) of "pressure", "shear" and "slip".

    A value is isolated if it is a spike: 5 times as large as its neighbours in x and in time, and 3
    times as large as all values that do not stand out so. A pressure or shear is isolated too by
    its difference from the reference. That is 5 times as large as its neighbours and as all others,
    and above a tenth of the largest reference. Such a pressure lies away from the edges of contact,
    such a shear from those of stick too. The difference of the slip is not used: each solution
    counts slip from another origin.
    """
    # edges (k, 2), left and right, beside which a difference may be large
    edges_by_field = {
        "pressure": [reference_cycle.contact_edges],
        "shear": [reference_cycle.contact_edges, reference_cycle.stick_edges],
    }
    masks = {
        name: spike_mask(getattr(result_cycle, name)) for name in ("pressure", "shear", "slip")
    }
    for name, edges_of_field in edges_by_field.items():
        reference_values = np.nan_to_num(getattr(reference_cycle, name))
        difference = getattr(result_cycle, name) - reference_values
        largest_reference = np.max(np.abs(reference_values), initial=0.0)
        is_large = np.abs(difference) > _LEAST_SHARE_OF_DIFFERENCE * largest_reference
        is_far_larger = _is_far_larger(difference, _FACTOR_OVER_DIFFERENCES)
        # with pressure at six points or fewer, no value can be told from the others
        is_isolated = is_far_larger & is_large & _has_enough_points(result_cycle.pressure)
        is_near_edge = _is_near_edge(edges_of_field, reference_cycle)
        masks[name] = masks[name] | (is_isolated & ~is_near_edge)
    return masks


def _is_near_edge(edges: Sequence[Array], cycle: Cycle) -> Mask:
    """(k instants, n points) whether a point of a cycle lies within two point spacings of one of
    the `edges` at an instant. Each of `edges` is (k, 2), left and right [length]; no point is near
    an edge that is NaN.
    """
    spacings = np.diff(cycle.x)
    spacing_after_point = np.append(spacings, spacings[-1])
    spacing_before_point = np.insert(spacings, 0, spacings[0])
    spacing = np.maximum(spacing_after_point, spacing_before_point)
    is_near_edge = np.zeros(cycle.pressure.shape, dtype=bool)
    with np.errstate(invalid="ignore"):
        for edge_pair in edges:
            for edge in edge_pair.T:
                is_near_edge |= np.abs(cycle.x - edge[:, None]) <= _SPACINGS_NEAR_EDGE * spacing
    return is_near_edge
