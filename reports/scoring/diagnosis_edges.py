"""A coarse mesh: not one prediction, but a place. What it gets wrong stays near the edges of contact and stick."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reports.scoring.diagnosis_discrepancy import Array, Discrepancy
from reports.scoring.diagnosis_hypothesis import Hypothesis

# Spacings to each side of an edge that a mesh can get wrong: the element with the edge in it, and its neighbour.
REACH = 2.0
# A traction that leaves the edge as a root is off by about sqrt(2 h/a) of its peak over the element with the edge: shear, at stick
# edges, by up to 1.2 of that on meshes of a/5 to a/24, pressure by up to 0.36, its edge being found to a part of an element
# (benchmarks/diagnosis.py). A soft layer or a short body moves the pressure's edge by 0.7 to 1.5 of that.
MOST = (0.4, 1.0)


def coarse_edge(what: Discrepancy) -> Iterator[Hypothesis]:
    """The part of the discrepancy within two spacings of an edge, as far as the spacing can account for its size.

    An elastic traction leaves the edge of contact as (1 - x/a)^(1/2), and q the stick edge likewise. Interpolated on elements of
    length h it is off by the order of p_ref sqrt(2 h/a) over the element with the edge. What goes beyond that is not the mesh's.
    """
    half = what.comparison.scales.half_width
    near, spacing = _near_edges(what)
    root = np.sqrt(2 * spacing / half)
    units = what.comparison.scales.pressure, what.comparison.scales.shear
    parts = []
    for found, expected, unit, most in zip(what.found, what.expected, units, MOST, strict=True):
        off = np.clip(found - expected, -most * root * unit, most * root * unit)
        parts.append(expected + np.where(near, off, 0.0))
    edge = float(np.median(spacing[near.any(axis=0)])) / half if near.any() else float("nan")
    yield Hypothesis("coarse_edge", (parts[0], parts[1]), {"spacing": edge})


def _near_edges(what: Discrepancy) -> tuple[Array, Array]:
    """(k, n) points within reach of an edge of the reference, and (n,) the spacing of the points.

    The edges are those of the instant, and those of the smallest stick zone: what a mesh gets wrong there stays locked in.
    """
    x = what.x
    steps = np.diff(x)
    spacing = np.maximum(np.append(steps, steps[-1]), np.insert(steps, 0, steps[0]))
    cycle = what.comparison.expected
    near = np.zeros(what.expected[0].shape, dtype=bool)
    for edges in (cycle.contact_edges[what.rows], cycle.stick_edges[what.rows]):
        for side in (0, 1):
            place = edges[:, side][:, None]
            with np.errstate(invalid="ignore"):
                near |= np.abs(x - place) <= REACH * spacing
    inner = np.abs(cycle.stick_edges)
    if np.isfinite(inner).any():
        near |= np.abs(np.abs(x) - np.nanmin(inner)) <= REACH * spacing
    return near, spacing
