"""Blocks, pads and cylinders: area, boundaries, the face where it truly is, mirror symmetry, shape, scale; what is refused."""

import functools
import itertools
import math

import numpy as np
import pytest
import skfem

from meshes import MeshSettings, SurfaceGrading, build, solid
from scenes import Block, Cylinder, FlatRounded, HalfPlane, Hertz, InputError, Pad, Tabulated, Wedge
from scenes.bodies import face_of

GRADING = SurfaceGrading(inner=0.6, outer=1.1, size=0.12, edge_size=0.05)
PAD = Pad(width=6.0, height=4.0)
ROWS = tuple((x / 4, (x / 4) ** 2 / 20) for x in range(13))
SHAPES = {
    "block": (Block(width=8.0, height=5.0), Hertz(radius=10.0)),
    "pad, hertz": (PAD, Hertz(radius=10.0)),
    "pad, flat_rounded": (PAD, FlatRounded(radius=4.0, flat_half_length=0.5)),
    "pad, flat to past the contact": (PAD, FlatRounded(radius=4.0, flat_half_length=1.5)),
    "pad, wedge": (PAD, Wedge(tip_radius=5.0, tip_half_length=0.5)),
    "pad, tabulated": (PAD, Tabulated(points=ROWS)),
    "cylinder": (Cylinder(radius=5.0), Hertz(radius=5.0)),
}
KINDS = tuple(itertools.product((1, 2), ("triangles", "quadrilaterals")))
EVERY = pytest.mark.parametrize(("name", "order", "cells"), [(name, *kind) for name in SHAPES for kind in KINDS])


@functools.cache
def body(name, order=2, cells="triangles"):
    return solid("upper", *SHAPES[name], GRADING, 0.25, order, cells)


def half_width(name):
    return SHAPES[name][0].face_half_width


def height(name):
    shape = SHAPES[name][0]
    return shape.radius if isinstance(shape, Cylinder) else shape.height


def area_under_parabola(width, radius):
    return width**3 / (24 * radius)


def exact_area(name):
    """By hand, each shape on its own."""
    shape, profile = SHAPES[name]
    if isinstance(shape, Cylinder):
        return math.pi * shape.radius**2 / 2
    rectangle, reach = shape.width * shape.height, shape.width / 2
    if isinstance(shape, Block):
        return rectangle
    if isinstance(profile, Wedge):
        b, R = profile.tip_half_length, profile.tip_radius
        return rectangle - 2 * (b**3 / (6 * R) + (reach - b) * b**2 / (2 * R) + b * (reach - b) ** 2 / (2 * R))
    if isinstance(profile, Tabulated):
        return rectangle - area_under_parabola(shape.width, 10.0)
    R, b = profile.radius, getattr(profile, "flat_half_length", 0.0)
    s = reach - b  # under the arc: R s less the segment of the circle
    return rectangle - 2 * (R * s - (s * math.sqrt(R**2 - s**2) + R**2 * math.asin(s / R)) / 2)


def places(name, boundary, order, cells):
    """(2, n) all nodes of a boundary, mid-side ones too, by ascending x."""
    mesh = body(name, order, cells).mesh
    scalar = {
        ("triangles", 1): skfem.ElementTriP1,
        ("triangles", 2): skfem.ElementTriP2,
        ("quadrilaterals", 1): skfem.ElementQuad1,
        ("quadrilaterals", 2): skfem.ElementQuad2,
    }[cells, order]
    basis = skfem.Basis(mesh, scalar(), intorder=2)
    found = basis.doflocs[:, basis.get_dofs(boundary).all()]
    return found[:, np.lexsort((found[1], found[0]))]


@EVERY
def test_every_boundary_facet_has_exactly_one_name(name, order, cells):
    mesh = body(name, order, cells).mesh
    assert set(mesh.boundaries) == {"contact", "free", "base"} | (set() if name == "cylinder" else {"sides"})
    named = np.concatenate([mesh.boundaries[key] for key in sorted(mesh.boundaries)])
    assert sorted(named.tolist()) == sorted(mesh.boundary_facets().tolist())
    assert mesh.t.shape[0] >= {"triangles": 3, "quadrilaterals": 4}[cells]


@EVERY
def test_boundaries_lie_where_they_are_named(name, order, cells):
    far, deep = half_width(name) * (1 - 1e-11), height(name) * (1 - 1e-11)
    contact, free, base = (places(name, key, order, cells) for key in ("contact", "free", "base"))
    assert contact[0].max() == -contact[0].min() == pytest.approx(GRADING.outer, rel=1e-12)
    assert np.abs(free[0]).min() == pytest.approx(GRADING.outer, rel=1e-12)
    assert far <= np.abs(free[0]).max() <= half_width(name)
    assert np.all(base[1] <= -deep)
    assert base[0].max() == -base[0].min() == pytest.approx(half_width(name), rel=1e-11)
    if name != "cylinder":
        sides = places(name, "sides", order, cells)
        assert np.all(np.abs(sides[0]) >= far)
        assert sides[1].min() == pytest.approx(-height(name), rel=1e-11)


@EVERY
def test_area(name, order, cells):
    """Worst of all: 5e-3 with straight sides; with curved ones 3.6e-6 for the cylinder's 90 degrees, 9e-8 where a flat ends."""
    one = body(name, order, cells)
    element = skfem.ElementTriP1() if cells == "triangles" else skfem.ElementQuad1()
    error = float(skfem.Basis(one.mesh, element, intorder=6).dx.sum()) / exact_area(name) - 1
    limits = {"block": (1e-11, 1e-11), "cylinder": (6e-3, 5e-6)}
    assert abs(error) < limits.get(name, (5e-4, 2e-7))[order - 1]
    assert one.quality["area_error"] == pytest.approx(error, abs=1e-9)


@EVERY
def test_contact_nodes_lie_on_the_true_face(name, order, cells):
    """Mid-side ones too, at the mean x of their corners: what the mortar coupling relies on."""
    x, y = places(name, "contact", order, cells)
    np.testing.assert_allclose(y, -face_of(*SHAPES[name]).depth(x), rtol=1e-12, atol=1e-16)
    if order == 2:
        np.testing.assert_allclose(x[1::2], (x[:-1:2] + x[2::2]) / 2, rtol=0, atol=2e-12)
    if name.startswith("pad") and order == 1:
        assert y.min() < -0.01 or name == "pad, flat to past the contact"


def test_that_test_tells_an_arc_from_a_parabola():
    x, y = places("pad, hertz", "contact", 2, "triangles")
    assert np.abs(y + np.square(x) / 20).max() == pytest.approx(1.1**4 / 8 / 10**3, rel=0.05)


@EVERY
def test_the_rest_of_the_face_lies_on_it_too(name, order, cells):
    x, y = places(name, "free", order, cells)
    if name == "cylinder":
        np.testing.assert_allclose(np.hypot(x, y + 5.0), 5.0, rtol=1e-11)
    else:
        np.testing.assert_allclose(y, -face_of(*SHAPES[name]).depth(x), rtol=0, atol=1e-11)


@EVERY
def test_points_and_elements_are_their_own_mirror_image_to_the_last_bit(name, order, cells):
    mesh = body(name, order, cells).mesh
    as_rows = lambda array: sorted(map(tuple, (array + 0.0).tolist()))  # noqa: E731
    assert as_rows(mesh.p.T) == as_rows(mesh.p.T * [-1.0, 1.0])
    corners = mesh.p[:, mesh.t[: mesh.refdom.nfacets]]  # (2, corners, elements)

    def outlines(sign):
        return {frozenset(zip((sign * x + 0.0).tolist(), y.tolist(), strict=True)) for x, y in corners.transpose(2, 0, 1)}

    assert outlines(1.0) == outlines(-1.0)


@EVERY
def test_surface_is_cut_as_asked(name, order, cells):
    x = places(name, "contact", order, cells)[0][::order]
    steps, inside = np.diff(x), np.abs(x[1:] + x[:-1]) / 2 < GRADING.inner
    # Quadrilaterals come in twos: six pieces of 0.1 where triangles have five of 0.12.
    np.testing.assert_allclose(steps[inside], GRADING.size if cells == "triangles" else 0.1, rtol=1e-9)
    np.testing.assert_allclose(steps[~inside], GRADING.edge_size, rtol=1e-9)


@EVERY
def test_quality(name, order, cells):
    """Worst of the triangles: 27 degrees, 0.70, 0.957; of the quadrilaterals: 28 degrees, 0.39, 0.888."""
    quality = body(name, order, cells).quality
    worst, mean = (0.6, 0.93) if cells == "triangles" else (0.25, 0.85)
    assert quality["least_angle"] > 20
    assert quality["worst_shape"] > worst
    assert quality["mean_shape"] > mean


@EVERY
def test_elements_are_not_folded(name, order, cells):
    """The Jacobian is positive at every Gauss point, curved sides included."""
    mesh = body(name, order, cells).mesh
    element = skfem.ElementTriP1() if cells == "triangles" else skfem.ElementQuad1()
    determinant = skfem.Basis(mesh, element, intorder=6).mapping.detDF(skfem.Basis(mesh, element, intorder=6).X)
    assert np.all(np.sign(determinant) == np.sign(determinant[:, :1]))


def scaled(name, length):
    """Shape and profile in other units."""
    shape, profile = SHAPES[name]
    lengths = {key: value * length for key, value in shape.model_dump().items() if isinstance(value, float)}
    if isinstance(profile, Tabulated):
        return shape.vary(**lengths), Tabulated(points=[(x * length, h * length) for x, h in ROWS])
    radii = {key: value * length for key, value in profile.model_dump().items() if isinstance(value, float)}
    return shape.vary(**lengths), profile.vary(**radii)


@pytest.mark.parametrize(("order", "cells"), [(1, "quadrilaterals"), (2, "triangles")])
@pytest.mark.parametrize("length", [1e-3, 1e3])
@pytest.mark.parametrize("name", SHAPES)
def test_scale_does_not_matter(name, length, order, cells):
    """Not even the numbering changes: gmsh is given lengths over the contact side, to twelve digits."""
    plain = body(name, order, cells)
    grading = SurfaceGrading(*(value * length for value in (GRADING.inner, GRADING.outer, GRADING.size, GRADING.edge_size)))
    other = solid("upper", *scaled(name, length), grading, 0.25, order, cells)
    np.testing.assert_array_equal(other.mesh.t, plain.mesh.t)
    np.testing.assert_allclose(other.mesh.p / length, plain.mesh.p, rtol=0, atol=1e-14 * 8)
    for key in plain.mesh.boundaries:
        np.testing.assert_array_equal(other.mesh.boundaries[key], plain.mesh.boundaries[key])


def test_build_makes_each_shape_and_reports_its_supports():
    settings = MeshSettings(growth=0.4)
    face = Hertz(radius=10.0)
    held = Block(width=8.0, height=5.0, base="rollers", sides="guided")
    assert build("lower", held, face, GRADING, settings).supports == {"base": "rollers", "sides": "guided"}
    assert build("upper", PAD, face, GRADING, settings).supports == {"base": "fixed"}
    assert build("upper", Cylinder(radius=5.0), face, GRADING, settings).supports == {"base": "fixed"}
    with_radius = SurfaceGrading(0.6, 1.1, 0.12, 0.05, 4.0)
    assert build("lower", HalfPlane(), face, with_radius, settings).supports == {"far_field": "half_plane"}


ROUGH = [(0.0, 0.1, 0.1), (0.95, 0.14, 0.02), (0.3, 0.05, 0.03)]


@pytest.mark.parametrize("cells", ["triangles", "quadrilaterals"])
@pytest.mark.parametrize("growth", [0.15, 1.0])
@pytest.mark.parametrize(("inner", "size", "edge_size"), ROUGH)
@pytest.mark.parametrize("name", ["pad, flat_rounded", "pad, tabulated"])
def test_corners_of_the_admitted_settings_make_sound_meshes(name, inner, size, edge_size, growth, cells):
    """Quadrilaterals with two sides in line along the face (shape 0.004) came out of these before."""
    one = solid("upper", *SHAPES[name], SurfaceGrading(inner, 1.1, size, edge_size), growth, 2, cells)
    assert one.quality["worst_shape"] > 0.15
    assert one.quality["least_angle"] > 10
    assert abs(one.quality["area_error"]) < 1e-5


def test_narrow_and_shallow_bodies_are_meshed():
    """A contact side of 97 % of the face, a pad just higher than its face is deep."""
    tight = solid("upper", Pad(width=2.2 / 0.97, height=0.07), Hertz(radius=10.0), GRADING, 0.4)
    assert tight.quality["worst_shape"] > 0.1
    assert abs(tight.quality["area_error"]) < 1e-8
    named = np.concatenate([tight.mesh.boundaries[key] for key in sorted(tight.mesh.boundaries)])
    assert sorted(named.tolist()) == sorted(tight.mesh.boundary_facets().tolist())


@pytest.mark.parametrize(
    ("shape", "sentence"),
    [
        (Block(width=2.2, height=5.0), "bodies.upper: the contact reaches |x| = 1.1, past the end of the block's face at 1.1: "),
        (Pad(width=2.0, height=5.0), "bodies.upper: the contact reaches |x| = 1.1, past the end of the pad's face at 1: "),
        (Cylinder(radius=1.05), "bodies.upper: the contact reaches |x| = 1.1, past the end of the cylinder's face at 1.05: "),
        (
            Pad(width=12.0, height=2.0),
            "bodies.upper.height = 2 is refused: the pad's face goes as deep at its sides; make it higher",
        ),
    ],
)
def test_refusals(shape, sentence):
    with pytest.raises(InputError) as caught:
        solid("upper", shape, Hertz(radius=10.0), GRADING)
    assert str(caught.value).startswith(sentence)


def test_the_height_at_which_a_pad_is_refused_is_that_of_its_face():
    depth = 10 - math.sqrt(10**2 - 6**2)
    solid("upper", Pad(width=12.0, height=depth * 1.05), Hertz(radius=10.0), GRADING, 0.4, 1)
    with pytest.raises(InputError, match="make it higher"):
        solid("upper", Pad(width=12.0, height=depth), Hertz(radius=10.0), GRADING, 0.4, 1)
