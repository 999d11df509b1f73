"""What the far field costs: orders in L of every multipole left out, and that the whole of it leaves nothing but mesh error."""

import itertools

import numpy as np
import pytest

import far_field_rings as far_field
from meshes import mesh_quality

RADII = (5.0, 10.0, 20.0)
# Order in 1/L of what is left out after each moment; like bodies have no use for odd moments.
LIKE = {0: 4, 1: 4, 2: 6, 3: 6}
UNLIKE = {0: 2, 1: 3, 2: 4, 3: 5}


@pytest.mark.parametrize("contact", ["full stick", "partial slip"])
@pytest.mark.parametrize("pair", ["like", "unlike"])
@pytest.mark.parametrize("name", ["p", "q"])
def test_each_multipole_left_out_has_its_order(contact, pair, name):
    for moments, order in (LIKE if pair == "like" else UNLIKE).items():
        errors = far_field.truncations(RADII)[contact, pair, name, moments]
        assert far_field.slope(errors) == pytest.approx(order, abs=0.2 if moments < 3 else 0.5), moments


@pytest.mark.parametrize("pair", ["like", "unlike"])
def test_pressed_bodies_without_friction_see_even_moments_alone(pair):
    for moments, order in LIKE.items():
        assert far_field.slope(far_field.truncations(RADII)["pressed", pair, "p", moments]) == pytest.approx(order, abs=0.2)


def test_resultants_alone_cost_what_theory_says_at_ten_half_widths():
    """Like bodies, collocation of half-planes: some 6e-5 of the normal and 4e-5 of the shear curvature."""
    errors = {name: far_field.truncations(RADII)["full stick", "like", name, 0][1] for name in ("p", "q")}
    assert 2e-5 < errors["p"] < 8e-5
    assert 1e-5 < errors["q"] < 5e-5


@pytest.mark.parametrize(("name", "most"), [("p", 2.5), ("q", 4.5)])
def test_whole_far_field_of_like_bodies(name, most):
    """The default growth of elements: between (a/L)^2 and (a/L)^4, below 1e-6 of p0 at L = 10a in any node."""
    errors = far_field.by_radius(far_field.DEFAULT_GROWTH)["like", name]
    assert 2 - 0.3 < far_field.slope(errors) < most
    assert far_field.by_radius(far_field.DEFAULT_GROWTH)["like", f"{name}, any node"][1] < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(("pair", "name", "order"), [("like", "p", 2), ("unlike", "p", 1), ("unlike", "q", 1)])
def test_whole_far_field_leaves_the_mesh_error_of_the_rings(pair, name, order):
    """The same elements near the contact: fourth order in the rings' elements, and in L what the rings beyond it would add."""
    coarse, fine = (far_field.by_radius(growth)[pair, name] for growth in (far_field.DEFAULT_GROWTH, far_field.FINE_GROWTH))
    lengths = [far_field.ring_length(growth) for growth in (far_field.DEFAULT_GROWTH, far_field.FINE_GROWTH)]
    assert np.log(coarse[1] / fine[1]) / np.log(lengths[0] / lengths[1]) == pytest.approx(4, abs=0.3)
    assert far_field.slope(fine) == pytest.approx(order, abs=0.3)
    assert far_field.by_radius(far_field.FINE_GROWTH)[pair, f"{name}, any node"][1] < 1e-7


def test_rings_keep_the_inner_mesh_and_its_mirror_image():
    inside = far_field.inner_mesh()
    body = far_field.with_rings(inside, 10.0)
    assert abs(mesh_quality(body.mesh, 50 * np.pi)["area_error"]) < 1e-4
    corners = {tuple(point) for point in body.mesh.p.T}
    assert {tuple(point) for point in inside.mesh.p.T} <= corners
    assert {(-x, y) for x, y in corners} == corners
    for first, second in itertools.combinations(("contact", "far_field", "free"), 2):
        assert not set(body.mesh.boundaries[first]) & set(body.mesh.boundaries[second])
