r"""What the far field of the half-disc costs: multipoles left out, the radius L, and the elements between the contact and the arc.

Two kinds of contact over |x| <= a = 1 at given loads, with prescribed zones, so that an answer is one linear solve and its errors
are smooth: full stick under P and Q, and partial slip; like bodies, and unlike ones with a Dundurs beta of
0.38. Errors are L2 over the contact, or the largest of any node, over the mean-free scale p0 = 2 P/(pi a).

*Truncation.* The arc follows the displacement of the first m moments of the nodal forces instead of all; the same mesh, so that the
mesh error cancels. The moment k moves the arc by (a/L)^k, which strains the disc by 1/L more for each power of x in what it does to
the contact: like bodies see even moments and even strains, (a/L)^4 with the resultants, (a/L)^6 with the quadrupole; unlike ones
have shear of odd parity too, whose dipole leaves (a/L)^2 with the resultants, and one power more for each moment.

*Radius and elements.* With all moments the far field is exact, and what is left is what the elements on the way to the arc cannot
follow. Rings of elements around one and the same inner mesh, ever finer, tell it apart: it falls with the fourth power of their
size, and with L as the rings beyond it would have added, (a/L)^2 for like bodies and a/L for unlike ones.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass, replace

import numpy as np
import pytest
import skfem
from numpy.typing import NDArray

from halfplane_fe.elasticity import CondensedBody, assemble, condense, factorise
from halfplane_fe.far_field import surface_force_displacement
from meshes import BodyMesh, SurfaceGrading, half_disc
from scenes import Elastic

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LOWER, UPPER = Elastic(young_modulus=1.0, poisson_ratio=0.1), Elastic(young_modulus=10.0, poisson_ratio=0.3)
PAIRS = {"like": LOWER, "unlike": UPPER}
FRICTION, SHEAR = 0.5, 0.6  # f and Q/(f P)
# Half-width of what sticks, a = 1; the stick zone of partial slip is that of like half-planes.
STICK = {"full stick": 1.0, "partial slip": (1 - SHEAR) ** 0.5}
INNER = 5.0
RADII, FARTHEST = (5.0, 10.0, 20.0), 160.0
MOMENTS = range(5)


# ------------------------------------------------------------------------------------------------------------------ mesh
def inner_mesh(growth: float = 0.4) -> BodyMesh:
    """A half-disc with ten elements a half-width on the contact."""
    return half_disc("inner", SurfaceGrading(0.0, 1.2, 1 / 10, 1 / 10, INNER), growth)


def with_rings(body: BodyMesh, radius: float) -> BodyMesh:
    """`body` with rings of quadratic triangles around it up to `radius`, 2^n times its own: its elements stay, the rings go on."""
    inside = body.mesh
    n_corners = int(inside.t.max()) + 1
    arc = inside.boundaries["far_field"]
    nodes = np.union1d(inside.facets[:, arc].ravel(), n_corners + arc)
    angles = np.arctan2(inside.doflocs[0, nodes], -inside.doflocs[1, nodes])
    nodes, angles = nodes[np.argsort(angles)], np.sort(angles)
    # A whole number of rings from one radius to its double, so that the rings of a larger body begin with those of a smaller one.
    n_rings = round(np.log2(radius / body.grading.radius)) * max(1, round(np.log(2) / (np.pi / len(arc))))
    radii = body.grading.radius * (radius / body.grading.radius) ** (np.arange(n_rings + 1) / n_rings)
    points, elements = [inside.doflocs.T], [np.vstack([inside.t, n_corners + inside.t2f]).T]
    for before, after in itertools.pairwise(radii):
        start = sum(len(some) for some in points)
        middle, end = start + np.arange(len(nodes)), start + len(nodes) + np.arange(len(nodes))
        points += [_circle((before + after) / 2, angles), _circle(after, angles)]
        elements.append(_ring(nodes, middle, end))
        nodes = end
    mesh = _mesh(np.vstack(points), np.vstack(elements), body.grading.outer, radius)
    return replace(body, mesh=mesh, grading=replace(body.grading, radius=radius))


def _circle(radius: float, angles: Array) -> Array:
    points = radius * np.column_stack([np.sin(angles), -np.cos(angles)])
    points[[0, -1], 1] = 0.0
    return points


def _ring(below: Indices, middle: Indices, above: Indices) -> Indices:
    """Six-node triangles between two rows of corners and mid-side nodes, cut symmetrically about x = 0."""
    left = np.arange(0, len(below) - 1, 2)
    m, r = left + 1, left + 2
    sides = (below[left], below[r], above[r], above[left], below[m], middle[r], above[m], middle[left], middle[m])
    rising = left < (len(below) - 1) / 2
    a, b, c, d, ab, bc, cd, da, centre = sides
    first = np.where(rising, [a, b, c, ab, bc, centre], [a, b, d, ab, centre, da])
    second = np.where(rising, [a, c, d, centre, cd, da], [b, c, d, bc, cd, centre])
    return np.hstack([first, second]).T


def _mesh(points: Array, elements: Indices, outer: float, radius: float) -> skfem.MeshTri2:
    """The mesh with its boundaries, corners numbered first."""
    corners = np.unique(elements[:, :3])
    order = np.concatenate([corners, np.setdiff1d(np.arange(len(points)), corners)])
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    mesh = skfem.MeshTri2(np.ascontiguousarray(points[order].T), np.ascontiguousarray(place[elements].T))
    facets = mesh.boundary_facets()
    x, y = mesh.p[:, mesh.facets[:, facets]]
    arc = np.all(np.hypot(x, y) > radius * (1 - 1e-9), axis=0)
    contact = np.all((y == 0) & (np.abs(x) < outer * (1 + 1e-9)), axis=0)
    return mesh.with_boundaries({"contact": facets[contact], "far_field": facets[arc], "free": facets[~arc & ~contact]})


# --------------------------------------------------------------------------------------------------------------- contact
@dataclass(frozen=True, eq=False)
class Tractions:
    """Pressure and shear at the nodes in contact over p0, and the nodes' share of the surface."""

    pressure: Array
    shear: Array
    weights: Array

    def apart(self, other: Tractions) -> dict[str, float]:
        """L2 over the contact of p and q less those of another, and the largest difference at any node."""
        share = self.weights / self.weights.sum()
        found = {}
        for name, off in (("p", self.pressure - other.pressure), ("q", self.shear - other.shear)):
            found[name], found[f"{name}, any node"] = float(np.sqrt(share @ off**2)), float(np.abs(off).max())
        return found


def solve(lower: Array, upper: Array, body: CondensedBody, materials: tuple[Elastic, Elastic], contact: str) -> Tractions:
    """p and q of one linear solve: gap zero over |x| <= 1, no slip over the stick zone, q = f p on the rest."""
    inside = np.flatnonzero(np.abs(body.x) <= 1 + 1e-9)
    n, x, part = len(inside), body.x[inside], np.ix_(inside, inside)
    stick = (np.abs(x) <= STICK[contact] + 1e-9)[:, None]
    modulus = 1 / sum((1 - one.poisson_ratio**2) / one.young_modulus for one in materials)
    both, apart = lower + upper, lower - upper
    matrix, right = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros(2 * n + 2)
    matrix[:n, :n], matrix[:n, n : 2 * n], matrix[:n, 2 * n] = both[1, :, 1, :][part], -apart[1, :, 0, :][part], -1.0
    right[:n] = -2 / (np.pi * modulus) * x**2  # the parabola that P = 1 presses to a = 1
    held = np.hstack([apart[0, :, 1, :][part], -both[0, :, 0, :][part], np.zeros((n, 1)), np.ones((n, 1))])
    sliding = np.hstack([-FRICTION * np.eye(n), np.eye(n), np.zeros((n, 2))])
    matrix[n : 2 * n] = np.where(stick, held, sliding)
    matrix[2 * n, :n], right[2 * n] = 1.0, 1.0
    matrix[2 * n + 1, n : 2 * n], right[2 * n + 1] = 1.0, SHEAR * FRICTION
    found = np.linalg.solve(matrix, right)
    weights = body.weights[inside]
    return Tractions(found[:n] / weights * np.pi / 2, found[n : 2 * n] / weights * np.pi / 2, weights)


# --------------------------------------------------------------------------------------------------------------- studies
def truncated_compliance(body: BodyMesh, material: Elastic, datum_length: float, moments: int | None) -> Array:
    """(2, n, 2, n) compliance with the displacement of the first `moments` of the nodal forces prescribed on the arc.

    It is not made symmetric: the mean with its transpose would carry the error of the tangential
    displacement, (a/L)^2, into the tractions.
    """
    system = assemble(body, material)
    places, contact = system.basis.doflocs, system.contact.ravel()
    young, nu = material.young_modulus, material.poisson_ratio
    at_arc, forces = places[:, system.arc[0]], places[0, system.contact[0]]
    moved = surface_force_displacement(*at_arc, forces, young, nu, datum_length, moments).reshape(system.arc.size, -1)
    load = -(system.stiffness[:, system.arc.ravel()] @ moved)
    load[contact] += np.eye(len(contact))
    found = np.zeros_like(load)
    found[system.free] = factorise(system.stiffness[system.free][:, system.free].tocsc()).solve(load[system.free])
    return found[contact].reshape(*system.contact.shape, *system.contact.shape)


@functools.cache
def truncations() -> dict[tuple[str, str, str, int], list[float]]:
    """(contact, pair, p or q, highest moment): L2 error at each of the radii against all moments on the same mesh."""
    found: dict[tuple[str, str, str, int], list[float]] = {}
    for radius in RADII:
        body = inner_mesh() if radius == INNER else with_rings(inner_mesh(), radius)
        one = condense(body, LOWER, 1.0)
        compliances = {
            (material, moments): truncated_compliance(body, material, 1.0, moments)
            for material in PAIRS.values()
            for moments in (*MOMENTS, None)
        }
        for contact, (pair, material), moments in itertools.product(STICK, PAIRS.items(), MOMENTS):
            cut, whole = (
                solve(compliances[LOWER, k], compliances[material, k], one, (LOWER, material), contact) for k in (moments, None)
            )
            for name, value in cut.apart(whole).items():
                found.setdefault((contact, pair, name, moments), []).append(value)
    return found


def slope(errors: list[float]) -> float:
    """Order in 1/L of errors at 5a, 10a, 20a ...: from 10a to 20a."""
    return float(np.log2(errors[1] / errors[2]))


@functools.cache
def by_radius(growth: float) -> dict[tuple[str, str], list[float]]:
    """(pair, p or q): difference at each of RADII from the farthest, the elements within INNER being the same.

    Elements are as large as `growth` times the distance from the contact, those of the rings as long as those of the inner arc.
    """
    start = inner_mesh(growth=growth)
    answers: dict[str, list[Tractions]] = {pair: [] for pair in PAIRS}
    for radius in (*RADII, FARTHEST):
        body = start if radius == INNER else with_rings(start, radius)
        condensed = {material: condense(body, material, 1.0) for material in PAIRS.values()}
        for pair, material in PAIRS.items():
            compliances = condensed[LOWER].compliance, condensed[material].compliance
            answers[pair].append(solve(*compliances, condensed[LOWER], (LOWER, material), "full stick"))
    found: dict[tuple[str, str], list[float]] = {}
    for pair, (*nearer, last) in answers.items():
        for answer in nearer:
            for name, value in answer.apart(last).items():
                found.setdefault((pair, name), []).append(value)
    return found


# Elements of the rings over their distance: the default mesh, and what it takes.
DEFAULT_GROWTH, FINE_GROWTH = 0.2, 0.04


def ring_length(growth: float) -> float:
    """Length of the rings' elements over their distance: the angle of an element of the inner arc."""
    return np.pi / len(inner_mesh(growth=growth).mesh.boundaries["far_field"])


# ------------------------------------------------------------------------------------------------------------------- tests
# Order in 1/L of what is left out after each moment; like bodies have no use for odd moments.
LIKE = {0: 4, 1: 4, 2: 6, 3: 6}
UNLIKE = {0: 2, 1: 3, 2: 4, 3: 5}


@pytest.mark.parametrize("contact", ["full stick", "partial slip"])
@pytest.mark.parametrize("pair", ["like", "unlike"])
@pytest.mark.parametrize("name", ["p", "q"])
def test_each_multipole_left_out_has_its_order(contact, pair, name):
    for moments, order in (LIKE if pair == "like" else UNLIKE).items():
        errors = truncations()[contact, pair, name, moments]
        assert slope(errors) == pytest.approx(order, abs=0.2 if moments < 3 else 0.5), moments


@pytest.mark.slow
@pytest.mark.parametrize(("pair", "name", "order"), [("like", "p", 2), ("unlike", "p", 1), ("unlike", "q", 1)])
def test_whole_far_field_leaves_the_mesh_error_of_the_rings(pair, name, order):
    """The same elements near the contact: fourth order in the rings' elements, and in L what the rings beyond it would add."""
    coarse, fine = (by_radius(growth)[pair, name] for growth in (DEFAULT_GROWTH, FINE_GROWTH))
    lengths = [ring_length(growth) for growth in (DEFAULT_GROWTH, FINE_GROWTH)]
    assert np.log(coarse[1] / fine[1]) / np.log(lengths[0] / lengths[1]) == pytest.approx(4, abs=0.3)
    assert slope(fine) == pytest.approx(order, abs=0.3)
    assert by_radius(FINE_GROWTH)[pair, f"{name}, any node"][1] < 1e-7
