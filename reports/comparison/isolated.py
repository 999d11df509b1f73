"""Single values of a result that none of their neighbours supports: a mistyped cell, a node that is
wrong.

# notation: p_ref largest value of a field of the reference
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reports.comparison.cycles import Cycle
from scenes import freeze
from scenes.array_types import Array

Mask = NDArray[np.bool_]

# A spike is so many times as large as its neighbours in x and in time, and so many times as large
# as all other values of its field: a traction may be singular at an edge, but not at one point of
# one instant alone.
_OVER_NEIGHBOURS = 5.0
_OVER_ALL = 3.0
# Points with a value at the instant of a spike: of a contact of fewer a mesh knows no form.
_FEWEST_BESIDE = 6
# The same of differences from the reference, of which noise has large ones by chance: so many times
# as large as all others, and at least this share of p_ref.
_DIFFERENCE_OVER_ALL = 5.0
_LEAST_DIFFERENCE = 0.1
# Spacings to each side of an edge of contact or stick: there a mesh errs at one node alone.
_NEAR_EDGE = 2.0


def spikes(values: Array) -> Mask:
    """Where single values of a field stand out of all others: (n_steps, n_points) -> mask.

    >>> field = np.full((1, 9), 2.0)
    >>> field[0, 4] = 900.0
    >>> np.flatnonzero(spikes(field)[0]).tolist()
    [4]
    """
    return _stands_out(values, _OVER_ALL) & _has_form(values)


def _stands_out(values: Array, over_all: float) -> Mask:
    """Which values of a field (k instants, n points) stand alone: each is several times larger than
    its neighbours in x and in time, and `over_all` times larger than every other value.
    """
    sizes = np.abs(np.nan_to_num(values))
    padded_sizes = np.pad(sizes, 1)
    value_left = padded_sizes[1:-1, :-2]
    value_right = padded_sizes[1:-1, 2:]
    value_before = padded_sizes[:-2, 1:-1]
    value_after = padded_sizes[2:, 1:-1]
    largest_neighbour = np.maximum.reduce([value_left, value_right, value_before, value_after])
    stands_out = (sizes > 0) & (sizes > _OVER_NEIGHBOURS * largest_neighbour)
    largest_of_rest = float(np.max(sizes, where=~stands_out, initial=0.0))
    return np.asarray(stands_out & (sizes > over_all * largest_of_rest))


def _has_form(values: Array) -> Mask:
    """(n_steps, 1) instants with enough values that are not 0."""
    count = np.sum(np.nan_to_num(values) != 0, axis=1, keepdims=True)
    return np.asarray(count > _FEWEST_BESIDE)


def without_spikes(values: Array) -> Array:
    """A field of values (n_steps, n_points) without its spikes, single values that are far larger
    than all others: in place of each stands the mean of both neighbours in x.
    """
    is_spike = spikes(values)
    if not is_spike.any():
        return values
    smooth_values = values.copy()
    for instant, point in np.argwhere(is_spike):
        neighbours = [
            neighbour
            for neighbour in (point - 1, point + 1)
            if 0 <= neighbour < values.shape[1] and not is_spike[instant, neighbour]
        ]
        smooth_values[instant, point] = np.mean(values[instant, neighbours]) if neighbours else 0.0
    return freeze(smooth_values)


def isolated_values(result_cycle: Cycle, reference_cycle: Cycle) -> dict[str, Mask]:
    """Which values of pressure, shear and slip in a result's last cycle stand alone, (k instants, n
    points) each by name: single values that are far larger than all others; and pressures and
    shears whose difference from the reference is such a value, away from the edges of contact and
    stick.

    Slip is counted from a datum of its own, so that its difference from the reference is not looked
    at.
    """
    edges = {
        "pressure": [reference_cycle.contact_edges],
        "shear": [reference_cycle.contact_edges, reference_cycle.stick_edges],
    }
    masks = {name: spikes(getattr(result_cycle, name)) for name in ("pressure", "shear", "slip")}
    for name, edges_of_field in edges.items():
        reference_values = np.nan_to_num(getattr(reference_cycle, name))
        difference = getattr(result_cycle, name) - reference_values
        largest_reference = np.max(np.abs(reference_values), initial=0.0)
        is_large = np.abs(difference) > _LEAST_DIFFERENCE * largest_reference
        stands_alone = _stands_out(difference, _DIFFERENCE_OVER_ALL)
        # A pressure of a few points has no form that a single value could stand out of.
        stands_alone &= _has_form(result_cycle.pressure)
        is_near_edge = _near(edges_of_field, reference_cycle)
        masks[name] = masks[name] | (stands_alone & is_large & ~is_near_edge)
    return masks


def _near(edges: Sequence[Array], cycle: Cycle) -> Mask:
    """(k, n) points within two spacings of one of the edges (k, 2) at their instant."""
    steps = np.diff(cycle.x)
    spacing = np.maximum(np.append(steps, steps[-1]), np.insert(steps, 0, steps[0]))
    is_near = np.zeros(cycle.pressure.shape, dtype=bool)
    with np.errstate(invalid="ignore"):
        for left_and_right in edges:
            for edge in left_and_right.T:
                is_near |= np.abs(cycle.x - edge[:, None]) <= _NEAR_EDGE * spacing
    return is_near
