"""How large a mesh will be, before gmsh or any matrix takes memory for it."""

from __future__ import annotations

import math

from meshes.bodies import SurfaceGrading
from scenes import InputError

# Nodes on the contact: their compliance is a full matrix of (2 n)^2 numbers, 2 GB at the limit. Nodes of a body: about 10 kB each
# while it is assembled and factorised.
MOST_CONTACT_NODES, MOST_NODES = 8_000, 500_000
# A body that ends somewhere has less of what is coarse; a radius for it, over the contact's.
_FAR = 1000.0


def contact_nodes(grading: SurfaceGrading, order: int) -> int:
    """Nodes on |x| <= outer."""
    elements = 2 * (grading.inner / grading.size + (grading.outer - grading.inner) / grading.edge_size)
    return round(elements) * order + 1


def body_nodes(grading: SurfaceGrading, growth: float, order: int) -> int:
    """Nodes of a half-disc graded so, within a factor of two: the area over that of an equilateral triangle of the size there.

    # notation: L fine length of surface, h its elements, g growth, d distance from it, R radius
    With size h + g d and dA = (pi d + L) dd the count is (4/sqrt 3) int_0^R (pi d + L)/(h + g d)^2 dd, in closed form.
    """
    count, g = 0.0, growth
    for length, h in ((2 * (grading.outer - grading.inner), grading.edge_size), (2 * grading.inner, grading.size)):
        if length > 0:
            reach = g * min(grading.radius, _FAR * grading.outer) / h
            count += (
                4
                / math.sqrt(3)
                * (math.pi / g**2 * (math.log1p(reach) - reach / (1 + reach)) + length / (g * h) * reach / (1 + reach))
            )
    return round(count * order**2 / 2)


def check_count(name: str, grading: SurfaceGrading, growth: float, order: int) -> None:
    """InputError where the mesh of body `name` would be too large, with the limit."""
    what = "make element_size and edge_element_size larger"
    if (count := contact_nodes(grading, order)) > MOST_CONTACT_NODES:
        raise InputError(
            f"mesh: the {name} body would have some {count:,} nodes on its contact, and the limit is {MOST_CONTACT_NODES:,}; {what}"
        )
    if (count := body_nodes(grading, growth, order)) > MOST_NODES:
        raise InputError(
            f"mesh: the {name} body would have about {count:,} nodes, and the limit is {MOST_NODES:,}; {what}, or growth"
        )
