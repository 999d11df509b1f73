"""Mortar coupling: patch tests on non-matching sides, resultants, and the same answer whichever side carries the multipliers."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import halfplane_fe
from halfplane_fe import SolverSettings
from halfplane_fe.mortar import Side, mortar
from meshes import MeshSettings
from scenes import Elastic, Materials, load_scene


def side(corners: np.ndarray, order: int) -> np.ndarray:
    """Nodes of a side with the given corner nodes."""
    nodes = np.empty(order * (len(corners) - 1) + 1)
    nodes[::order] = corners
    if order == 2:
        nodes[1::2] = (corners[1:] + corners[:-1]) / 2
    return nodes


def element_loads(nodes: np.ndarray, order: int) -> np.ndarray:
    """Consistent nodal forces of a unit uniform traction."""
    loads = np.zeros_like(nodes)
    shares = np.array([1, 1]) / 2 if order == 1 else np.array([1, 4, 1]) / 6
    for k in range((len(nodes) - 1) // order):
        members = np.arange(order * k, order * k + order + 1)
        loads[members] += shares * (nodes[members[-1]] - nodes[members[0]])
    return loads


def mortar_projection(lower: np.ndarray, upper: np.ndarray, order: int) -> np.ndarray:
    """What takes values of a flat upper side to the lower one: the same for either component."""
    coupled = mortar(Side(lower, 0 * lower, order), Side(upper, 0 * upper, order))
    np.testing.assert_array_equal(coupled.upper[0, :, 1], coupled.upper[1, :, 0])
    return coupled.upper[0, :, 1]


@st.composite
def two_sides(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, int]:
    order = draw(st.sampled_from([1, 2]))

    def one() -> np.ndarray:
        steps = np.array(draw(st.lists(st.floats(0.1, 1.0), min_size=1, max_size=9)))
        return side(np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum(), order)

    return one(), one(), order


@given(two_sides())
def test_patch_uniform_and_linear_displacement_pass(sides: tuple[np.ndarray, np.ndarray, int]) -> None:
    lower, upper, order = sides
    projection = mortar_projection(lower, upper, order)
    for power in range(order + 1):
        np.testing.assert_allclose(projection @ upper**power, lower**power, atol=1e-11)


@given(two_sides())
def test_patch_uniform_traction_passes_as_consistent_forces(sides: tuple[np.ndarray, np.ndarray, int]) -> None:
    lower, upper, order = sides
    forces = element_loads(lower, order)
    received = mortar_projection(lower, upper, order).T @ forces
    np.testing.assert_allclose(received, element_loads(upper, order), atol=1e-12)


@given(two_sides(), st.integers(0, 10_000))
def test_resultant_and_moment_are_kept(sides: tuple[np.ndarray, np.ndarray, int], seed: int) -> None:
    lower, upper, order = sides
    forces = np.random.default_rng(seed).standard_normal(len(lower))
    received = mortar_projection(lower, upper, order).T @ forces
    np.testing.assert_allclose([received.sum(), received @ upper], [forces.sum(), forces @ lower], atol=1e-10)


def test_matching_sides_give_the_identity() -> None:
    nodes = side(np.array([0.0, 0.1, 0.5, 1.0]), 2)
    np.testing.assert_allclose(mortar_projection(nodes, nodes, 2), np.eye(7), atol=1e-13)


def test_sides_of_different_extent_are_refused() -> None:
    with pytest.raises(ValueError, match="begin and end together"):
        mortar_projection(np.array([0.0, 1.0]), np.array([0.0, 1.1]), 1)


def test_swapping_the_sides_changes_less_than_the_mesh_error() -> None:
    """Ratio 3 : 2 one way and the other, against each other and against the matching mesh of the finer size."""
    scene = load_scene("cattaneo-mindlin")
    fine, coarse = 1 / 60, 1 / 40
    one = halfplane_fe.solve(scene, MeshSettings(element_size=1 / 16, edge_element_size=fine, upper_ratio=fine / coarse * 9 / 4))
    other = halfplane_fe.solve(scene, MeshSettings(element_size=1 / 16 * 1.5, edge_element_size=coarse, upper_ratio=2 / 3))
    mesh_error = 1e-3  # of the dissipation at h = a/40, measured against the closed form: 7e-4
    assert abs(one.dissipation / other.dissipation - 1) < mesh_error
    assert one.work.counts["condensations"] == other.work.counts["condensations"] == 2
    assert max(float(values.max()) for values in one.record.certificates.values()) < 1e-9


STEEL, ALUMINIUM = Elastic(young_modulus=210e3, poisson_ratio=0.3), Elastic(young_modulus=70e3, poisson_ratio=0.33)


@functools.cache
def unlike(lower: Elastic, upper: Elastic, size: float, ratio: float) -> halfplane_fe.FiniteElementSolution:
    scene = load_scene("cattaneo-mindlin").vary(material=Materials(lower=lower, upper=upper))
    mesh = MeshSettings(element_size=size, edge_element_size=size, upper_ratio=ratio)
    return halfplane_fe.solve(scene, mesh, SolverSettings(steps_per_cycle=24, step_tolerance=np.inf))


def apart(one: halfplane_fe.FiniteElementSolution, other: halfplane_fe.FiniteElementSolution, mirrored: bool) -> np.ndarray:
    """Largest L2 difference of p and of q over ||p|| at four instants of the path, and difference of W."""
    grid = np.linspace(-1.2, 1.2, 2001) * one.scales.half_width
    found = []
    for time in (2.0, 5.5, 6.0, 7.0):
        here, there = (int(np.argmin(np.abs(answer.time - time))) for answer in (one, other))
        size = np.linalg.norm(np.interp(grid, one.x, one.pressure[here]))
        row = []
        for name in ("pressure", "shear"):
            values = np.interp(-grid if mirrored else grid, other.x, getattr(other, name)[there])
            row.append(np.linalg.norm(np.interp(grid, one.x, getattr(one, name)[here]) - values) / size)
        found.append(row)
    return np.array([*np.max(found, axis=0), abs(one.dissipation / other.dissipation - 1)])


def test_swapping_unlike_bodies_on_sides_that_do_not_match_changes_less_than_the_mesh_error() -> None:
    """The picture turned upside down: p(x) -> p(-x), q(x) -> q(-x), W the same. Mesh error: what halving every element changes."""
    size, ratio = 1 / 20, 1.5
    plain, swapped = unlike(STEEL, ALUMINIUM, size, ratio), unlike(ALUMINIUM, STEEL, size * ratio, 1 / ratio)
    mesh_error = apart(plain, unlike(STEEL, ALUMINIUM, size / 2, ratio), False)
    mesh_error += apart(swapped, unlike(ALUMINIUM, STEEL, size * ratio / 2, 1 / ratio), False)
    assert np.all(apart(plain, swapped, True) < mesh_error), (apart(plain, swapped, True), mesh_error)
    assert np.all(mesh_error < [0.03, 0.06, 0.015])  # an error large enough would hide anything
    assert np.all(apart(plain, swapped, False)[:2] > mesh_error[:2])  # not turned round: the check sees it
