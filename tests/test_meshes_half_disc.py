"""Half-discs: area, boundaries, mirror symmetry, shape, scale; settings that are refused."""

import functools
import math

import gmsh
import numpy as np
import pytest
import skfem

from meshes import MeshSettings, SurfaceGrading, half_disc, mesh_quality
from scenes import InputError

GRADED = SurfaceGrading(inner=0.6, outer=1.1, size=0.12, edge_size=0.05, radius=6.0)
EVEN = SurfaceGrading(inner=0.0, outer=1.1, size=0.1, edge_size=0.1, radius=6.0)
GRADINGS = {"graded": GRADED, "even": EVEN}
NAMES = {"contact", "free", "far_field"}


@functools.cache
def body(name="graded", order=2, growth=0.25):
    return half_disc(name, GRADINGS[name], growth, order)


EVERY = pytest.mark.parametrize(("name", "order"), [(name, order) for name in GRADINGS for order in (1, 2)])


@EVERY
def test_area(name, order):
    """Curved six-node triangles follow the arc to 6e-6, chords to 8.5e-3 of the area."""
    one = body(name, order)
    exact = math.pi * GRADINGS[name].radius ** 2 / 2
    meshed = float(skfem.Basis(one.mesh, skfem.ElementTriP1(), intorder=6).dx.sum())
    assert abs(meshed / exact - 1) < (1e-5 if order == 2 else 1.2e-2)
    assert one.quality["area_error"] == pytest.approx(meshed / exact - 1, abs=1e-12)
    assert meshed < exact


@EVERY
def test_every_boundary_facet_has_exactly_one_name(name, order):
    mesh = body(name, order).mesh
    assert set(mesh.boundaries) == NAMES
    named = np.concatenate([mesh.boundaries[key] for key in sorted(NAMES)])
    assert sorted(named.tolist()) == sorted(mesh.boundary_facets().tolist())


@EVERY
def test_boundaries_lie_where_they_are_named(name, order):
    mesh, grading = body(name, order).mesh, GRADINGS[name]
    x, y = (mesh.p[i][mesh.facets] for i in (0, 1))  # (2, n_facets): both corners
    contact, free, arc = (mesh.boundaries[key] for key in ("contact", "free", "far_field"))
    np.testing.assert_array_equal(y[:, np.concatenate([contact, free])], 0.0)
    assert np.all(np.abs(x[:, contact]) <= grading.outer * (1 + 1e-12))
    assert np.all(np.abs(x[:, free]).max(axis=0) > grading.outer)
    np.testing.assert_allclose(np.hypot(x, y)[:, arc], grading.radius, rtol=1e-10)
    length = lambda facets: float(np.hypot(*(np.diff(v[:, facets], axis=0) for v in (x, y))).sum())  # noqa: E731
    assert length(contact) == pytest.approx(2 * grading.outer, rel=1e-12)
    assert length(free) == pytest.approx(2 * (grading.radius - grading.outer), rel=1e-10)
    assert length(arc) == pytest.approx(math.pi * grading.radius, rel=2e-2)


@EVERY
def test_points_are_their_own_mirror_image_to_the_last_bit(name, order):
    points = body(name, order).mesh.p.T
    mirrored = points * [-1.0, 1.0]
    as_rows = lambda array: sorted(map(tuple, (array + 0.0).tolist()))  # noqa: E731
    assert as_rows(points) == as_rows(mirrored)


@EVERY
def test_elements_are_their_own_mirror_image(name, order):
    mesh = body(name, order).mesh
    centre = mesh.p[:, mesh.t[:3]].mean(axis=1).T.round(12) + 0.0
    assert set(map(tuple, centre.tolist())) == set(map(tuple, (centre * [-1.0, 1.0] + 0.0).tolist()))
    corners = mesh.p[:, mesh.t[:3]]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    assert np.all(np.abs(one[0] * two[1] - one[1] * two[0]) > 0)


def test_mid_side_points_of_the_arc_lie_on_it():
    mesh = body().mesh
    arc = mesh.boundaries["far_field"]
    on_arc = np.hypot(*mesh.p) > GRADED.radius * (1 - 1e-10)
    assert np.count_nonzero(on_arc) == 2 * len(arc) + 1
    chords = np.hypot(*mesh.p[:, mesh.facets[:, arc]].mean(axis=1))
    assert np.all(chords < GRADED.radius * (1 - 1e-6))


@EVERY
def test_surface_is_graded_as_asked(name, order):
    mesh, grading = body(name, order).mesh, GRADINGS[name]
    x = np.sort(np.unique(mesh.p[0][mesh.facets[:, mesh.boundaries["contact"]]]))
    steps, middles = np.diff(x), np.abs(x[1:] + x[:-1]) / 2
    edges, centre = steps[middles > grading.inner], steps[middles < grading.inner]
    assert edges == pytest.approx(grading.edge_size, rel=0.1)
    if grading.inner:
        assert centre == pytest.approx(grading.size, rel=0.1)
        assert np.any(np.isclose(x, grading.inner, atol=1e-12))


@EVERY
def test_quality(name, order):
    """Worst of the four: 28 degrees, 0.71 and 0.956."""
    quality = body(name, order).quality
    assert quality["least_angle"] > 25
    assert quality["worst_shape"] > 0.6
    assert quality["mean_shape"] > 0.9
    assert quality["elements"] == body(name, order).mesh.t.shape[1]
    assert quality["nodes"] == body(name, order).mesh.p.shape[1]


def test_quality_of_known_triangles():
    equilateral = skfem.MeshTri(np.array([[0, 1, 0.5], [0, 0, math.sqrt(3) / 2]]), np.array([[0], [1], [2]]))
    figures = mesh_quality(equilateral, exact_area=math.sqrt(3) / 4)
    assert figures["least_angle"] == pytest.approx(60)
    assert figures["worst_shape"] == figures["mean_shape"] == pytest.approx(1.0)
    assert figures["area_error"] == pytest.approx(0.0, abs=1e-14)
    sliver = skfem.MeshTri(np.array([[0, 1, 0.5], [0, 0, 1e-3]]), np.array([[0], [1], [2]]))
    poor = mesh_quality(sliver, exact_area=1e-3)
    assert poor["least_angle"] < 0.2
    assert poor["worst_shape"] < 0.01
    assert poor["area_error"] == pytest.approx(-0.5)
    assert poor["size_ratio"] == pytest.approx(2.0, rel=1e-5)


@pytest.mark.parametrize("order", [1, 2])
def test_growth_makes_fewer_elements_and_order_two_more_nodes(order):
    assert body("graded", order, 0.5).quality["elements"] < body("graded", order, 0.25).quality["elements"]
    assert body("graded", 2).quality["elements"] == body("graded", 1).quality["elements"]
    assert body("graded", 2).quality["nodes"] > 3 * body("graded", 1).quality["nodes"]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("length", [1e-9, 1e9, 7.0, 1 / 3, 1.0573])
def test_scale_does_not_matter(order, length):
    plain = body("graded", order)
    values = (getattr(GRADED, field) * length for field in ("inner", "outer", "size", "edge_size", "radius"))
    scaled = half_disc("scaled", SurfaceGrading(*values), 0.25, order)
    np.testing.assert_array_equal(scaled.mesh.t, plain.mesh.t)
    np.testing.assert_allclose(scaled.mesh.p, plain.mesh.p * length, rtol=0, atol=1e-11 * length)
    for name in NAMES:
        np.testing.assert_array_equal(scaled.mesh.boundaries[name], plain.mesh.boundaries[name])
    assert scaled.quality["area_error"] == pytest.approx(plain.quality["area_error"], abs=1e-9)


def test_same_grading_same_mesh():
    again = half_disc("graded", GRADED, 0.25, 2)
    np.testing.assert_array_equal(again.mesh.p, body().mesh.p)
    np.testing.assert_array_equal(again.mesh.t, body().mesh.t)


def test_gmsh_is_left_as_it_was_found():
    body()
    assert not gmsh.isInitialized()


@pytest.mark.parametrize("growth", [0.1, 1.0])
@pytest.mark.parametrize("radius", [2.2, 40.0])
@pytest.mark.parametrize(("inner", "size", "edge_size"), [(0.0, 0.25, 0.25), (0.9, 0.2, 0.02), (0.5, 0.1, 0.1)])
def test_corners_of_the_admitted_settings_make_sound_meshes(inner, size, edge_size, radius, growth):
    """Worst of the twelve: 19 degrees, and an area wrong by 1e-3 with a handful of elements along the arc."""
    one = half_disc("any", SurfaceGrading(inner, 1.1, size, edge_size, radius), growth, 2)
    assert one.quality["least_angle"] > 12
    assert abs(one.quality["area_error"]) < 5e-3
    named = np.concatenate([one.mesh.boundaries[key] for key in sorted(NAMES)])
    assert sorted(named.tolist()) == sorted(one.mesh.boundary_facets().tolist())


def test_default_settings_are_fit_for_use():
    default = MeshSettings()
    grading = SurfaceGrading(0.67, 1.06, default.element_size, default.edge_element_size, default.far_radius)
    quality = half_disc("default", grading, default.growth, default.order).quality
    assert quality["least_angle"] > 20  # 23
    assert abs(quality["area_error"]) < 1e-4


@pytest.mark.parametrize(
    ("settings", "rule"),
    [
        ({"element_size": 0.0}, "element_size = 0.0"),
        ({"element_size": 0.3}, r"\[0.0001, 0.25\]"),
        ({"edge_element_size": -0.1}, "edge_element_size = -0.1"),
        ({"edge_element_size": float("nan")}, "edge_element_size = nan"),
        ({"edge_element_size": 0.2, "element_size": 0.1}, "at most element_size = 0.1"),
        ({"far_radius": 1.0}, "far_radius = 1.0"),
        ({"far_radius": float("inf")}, "far_radius = inf"),
        ({"growth": 0.0}, "growth = 0.0"),
        ({"growth": 1.5}, "growth = 1.5"),
        ({"order": 3}, "order = 3 is refused: it is 1 or 2"),
    ],
)
def test_settings_refuse_bad_values(settings, rule):
    with pytest.raises(InputError, match=rule) as caught:
        MeshSettings(**settings)
    assert str(caught.value).startswith("mesh: ")
