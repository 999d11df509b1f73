"""Meshes of half-discs, blocks, pads, cylinders, T-shapes and shouldered pads: area, named
boundaries, true face, mirror symmetry; files; Ctrl-C.
"""

import dataclasses
import functools
import itertools
import math
import os
import signal

import gmsh
import numpy as np
import pytest
import skfem

from meshes import MeshSettings, SurfaceGrading, half_disc, mesh_quality, solid
from meshes.bodies import surface_points
from meshes.interrupts import interrupts_wait
from refusals import refused_for
from scenes import (
    Block,
    Cylinder,
    FlatRounded,
    Hertz,
    InputError,
    Pad,
    ShoulderedPad,
    Tabulated,
    TShape,
    Wedge,
)
from scenes.bodies import face_of

DISC = SurfaceGrading(inner=0.6, outer=1.1, size=0.12, edge_size=0.05, radius=6.0)
EVEN = SurfaceGrading(inner=0.0, outer=1.1, size=0.1, edge_size=0.1, radius=6.0)
DISCS = {"disc, graded": DISC, "disc, even": EVEN}
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
    "t_shape": (
        TShape(width=8.0, flange_height=2.0, stem_width=4.0, height=5.0),
        Hertz(radius=10.0),
    ),
    "shouldered pad": (
        ShoulderedPad(width=4.0, shoulder_depth=2.0, shoulder_width=9.0, height=5.0),
        Hertz(radius=10.0),
    ),
}
KINDS = tuple(itertools.product((1, 2), ("triangles", "quadrilaterals")))
CASES = [
    *((name, order, "triangles") for name in DISCS for order in (1, 2)),
    *((name, *kind) for name in SHAPES for kind in KINDS),
]
EVERY = pytest.mark.parametrize(("name", "order", "cells"), CASES)


@functools.cache
def body(name, order=2, cells="triangles"):
    return (
        half_disc(name, DISCS[name], 0.25, order)
        if name in DISCS
        else solid("upper", *SHAPES[name], GRADING, 0.25, order, cells)
    )


def half_width(name):
    return DISC.radius if name in DISCS else SHAPES[name][0].face_half_width


def deepest(name):
    shape = Cylinder(radius=DISC.radius) if name in DISCS else SHAPES[name][0]
    return shape.radius if isinstance(shape, Cylinder) else shape.height


def exact_area(name):
    """By hand, each shape on its own."""
    if name in DISCS:
        return math.pi * DISC.radius**2 / 2
    shape, profile = SHAPES[name]
    if isinstance(shape, Cylinder):
        return math.pi * shape.radius**2 / 2
    rectangle = shape.width * shape.height
    reach = shape.width / 2
    if isinstance(shape, Block):
        return rectangle
    if isinstance(shape, TShape):
        return 8.0 * 2.0 + 4.0 * 3.0
    if isinstance(shape, ShoulderedPad):
        rectangle = 4.0 * 2.0 + 9.0 * 3.0
    if isinstance(profile, Wedge):
        b = profile.tip_half_length
        R = profile.tip_radius
        return rectangle - 2 * (
            b**3 / (6 * R) + (reach - b) * b**2 / (2 * R) + b * (reach - b) ** 2 / (2 * R)
        )
    if isinstance(profile, Tabulated):
        return rectangle - shape.width**3 / (24 * 10.0)
    R = profile.radius
    b = getattr(profile, "flat_half_length", 0.0)
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
    nodes = basis.doflocs[:, basis.get_dofs(boundary).all()]
    return nodes[:, np.lexsort((nodes[1], nodes[0]))]


def depth(name, x):
    """How deep the face lies at x."""
    return 0 * x if name in DISCS else face_of(*SHAPES[name]).depth(x)


@EVERY
def test_boundaries_have_one_name_each_and_lie_where_they_are_named(name, order, cells):
    mesh = body(name, order, cells).mesh
    grading = DISCS.get(name, GRADING)
    held = {"base", "sides"}
    if name in DISCS:
        held = {"far_field"}
    elif name == "cylinder":
        held = {"base"}
    assert set(mesh.boundaries) == {"contact", "free"} | held
    facets = np.concatenate([mesh.boundaries[key] for key in sorted(mesh.boundaries)])
    assert sorted(facets.tolist()) == sorted(mesh.boundary_facets().tolist())
    far = half_width(name) * (1 - 1e-11)
    contact, free = (places(name, key, order, cells) for key in ("contact", "free"))
    assert contact[0].max() == -contact[0].min() == pytest.approx(grading.outer, rel=1e-12)
    assert np.abs(free[0]).min() == pytest.approx(grading.outer, rel=1e-12)
    assert far <= np.abs(free[0]).max() <= half_width(name) * (1 + 1e-11)
    if name in DISCS:  # mid-side points too
        np.testing.assert_allclose(
            np.hypot(*places(name, "far_field", order, cells)), grading.radius, rtol=1e-10
        )
        return
    base = places(name, "base", order, cells)
    assert np.all(base[1] <= -deepest(name) * (1 - 1e-11))
    stepped = {"t_shape": 2.0, "shouldered pad": 4.5}
    half_of_base = stepped.get(name, half_width(name))
    assert base[0].max() == -base[0].min() == pytest.approx(half_of_base, rel=1e-11)
    if name != "cylinder":
        sides = places(name, "sides", order, cells)
        if name in stepped:
            above = np.isclose(np.abs(sides[0]), half_width(name)) & (sides[1] > -2.0 - 1e-9)
            below = np.isclose(np.abs(sides[0]), half_of_base) & (sides[1] < -2.0 + 1e-9)
            assert np.all(above | below | np.isclose(sides[1], -2.0))
            assert above.any()
            assert below.any()
        else:
            assert np.all(np.abs(sides[0]) >= far)
        assert sides[1].min() == pytest.approx(-deepest(name), rel=1e-11)


@EVERY
def test_area_and_shape(name, order, cells):
    """Worst area: 8.5e-3 with chords, 6e-6 with curved sides; angles 27 degrees, shapes 0.70 and
    0.39. None is folded.
    """
    meshed = body(name, order, cells)
    element = skfem.ElementTriP1() if cells == "triangles" else skfem.ElementQuad1()
    basis = skfem.Basis(meshed.mesh, element, intorder=6)
    error = float(basis.dx.sum()) / exact_area(name) - 1
    limits = dict.fromkeys(("block", "t_shape"), (1e-11, 1e-11)) | {"cylinder": (6e-3, 5e-6)}
    limits |= dict.fromkeys(DISCS, (1.2e-2, 1e-5))
    assert abs(error) < limits.get(name, (5e-4, 2e-7))[order - 1]
    assert meshed.quality["area_error"] == pytest.approx(error, abs=1e-9)
    worst, mean = (0.6, 0.9) if cells == "triangles" else (0.25, 0.85)
    assert meshed.quality["least_angle"] > 20
    assert meshed.quality["worst_shape"] > worst
    assert meshed.quality["mean_shape"] > mean
    assert (meshed.quality["elements"], meshed.quality["nodes"]) == (
        meshed.mesh.t.shape[1],
        meshed.mesh.p.shape[1],
    )
    determinant = basis.mapping.detDF(basis.X)
    assert np.all(np.sign(determinant) == np.sign(determinant[:, :1]))


@EVERY
def test_nodes_lie_on_the_true_face_cut_as_asked(name, order, cells):
    """Mid-side ones too, at the mean x of their corners: what the mortar coupling relies on. An arc
    is no parabola.
    """
    grading = DISCS.get(name, GRADING)
    x, y = places(name, "contact", order, cells)
    np.testing.assert_allclose(y, -depth(name, x), rtol=1e-12, atol=1e-16)
    if order == 2:
        np.testing.assert_allclose(x[1::2], (x[:-1:2] + x[2::2]) / 2, rtol=0, atol=2e-12)
    if name == "pad, hertz":
        assert np.abs(y + np.square(x) / 20).max() == pytest.approx(1.1**4 / 8 / 10**3, rel=0.05)
    corners = x[::order]
    steps = np.diff(corners)
    inside = np.abs(corners[1:] + corners[:-1]) / 2 < grading.inner
    # Quadrilaterals come in twos: six pieces of 0.1 where triangles have five of 0.12.
    np.testing.assert_allclose(
        steps[inside], grading.size if cells == "triangles" else 0.1, rtol=1e-9
    )
    np.testing.assert_allclose(steps[~inside], grading.edge_size, rtol=1e-9)
    x, y = places(name, "free", order, cells)
    np.testing.assert_allclose(
        np.hypot(x, y + 5.0) if name == "cylinder" else y + depth(name, x),
        5.0 * (name == "cylinder"),
        rtol=1e-11,
        atol=1e-11,
    )


@EVERY
def test_points_and_elements_are_their_own_mirror_image_to_the_last_bit(name, order, cells):
    mesh = body(name, order, cells).mesh
    as_rows = lambda array: sorted(map(tuple, (array + 0.0).tolist()))  # noqa: E731
    assert as_rows(mesh.p.T) == as_rows(mesh.p.T * [-1.0, 1.0])
    corners = mesh.p[:, mesh.t[: mesh.refdom.nfacets]]  # (2, corners, elements)

    def outlines(sign):
        return {
            frozenset(zip((sign * x + 0.0).tolist(), y.tolist(), strict=True))
            for x, y in corners.transpose(2, 0, 1)
        }

    assert outlines(1.0) == outlines(-1.0)


def test_quality_of_known_triangles():
    for third, area, least, shape, error in (
        (math.sqrt(3) / 2, math.sqrt(3) / 4, 60, 1.0, 0.0),
        (1e-3, 1e-3, 0.115, 2.31e-3, -0.5),
    ):
        mesh = skfem.MeshTri(np.array([[0, 1, 0.5], [0, 0, third]]), np.array([[0], [1], [2]]))
        quality = mesh_quality(mesh, exact_area=area)
        assert quality["least_angle"] == pytest.approx(least, rel=0.01)
        assert quality["worst_shape"] == quality["mean_shape"] == pytest.approx(shape, rel=0.02)
        assert quality["area_error"] == pytest.approx(error, abs=1e-14)
    assert quality["size_ratio"] == pytest.approx(2.0, rel=1e-5)


ROUGH = [(0.0, 0.1, 0.1), (0.95, 0.14, 0.02), (0.3, 0.05, 0.03)]


@pytest.mark.parametrize("growth", [0.1, 1.0])
@pytest.mark.parametrize(("inner", "size", "edge_size"), ROUGH)
@pytest.mark.parametrize(
    ("name", "cells"),
    [
        ("pad, flat_rounded", "triangles"),
        ("pad, tabulated", "quadrilaterals"),
        ("disc, even", "triangles"),
    ],
)
def test_corners_of_the_admitted_settings_make_sound_meshes(
    name, cells, inner, size, edge_size, growth
):
    """Quadrilaterals with two sides in line along the face (shape 0.004) came out of these
    before.
    """
    for radius in (2.2, 40.0) if name in DISCS else (None,):
        grading = SurfaceGrading(inner, 1.1, size, edge_size, *([radius] if radius else []))
        meshed = (
            half_disc("any", grading, growth, 2)
            if radius
            else solid("upper", *SHAPES[name], grading, growth, 2, cells)
        )
        assert meshed.quality["worst_shape"] > 0.15
        assert meshed.quality["least_angle"] > 10
        assert abs(meshed.quality["area_error"]) < (5e-3 if radius else 1e-5)


# ----------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("shape", "facts"),
    [
        (Block(width=2.2, height=5.0), ("bodies.upper", "|x| = 1.1", "block's face at 1.1")),
        (Pad(width=2.0, height=5.0), ("bodies.upper", "|x| = 1.1", "pad's face at 1:")),
        (Cylinder(radius=1.05), ("bodies.upper", "|x| = 1.1", "cylinder's face at 1.05")),
        (Pad(width=12.0, height=2.0), ("bodies.upper.height = 2", "pad's face", "make it higher")),
        (
            ShoulderedPad(width=12.0, shoulder_depth=2.0, shoulder_width=14.0, height=5.0),
            ("bodies.upper.shoulder_depth = 2", "pad's face"),
        ),
    ],
)
def test_refusals(shape, facts):
    with refused_for(*facts):
        solid("upper", shape, Hertz(radius=10.0), GRADING)


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


# -------------------------------------------------------------------------------- files, interrupts


def test_an_interrupt_waits_until_the_end():
    reached = []

    def interrupted():
        with interrupts_wait():
            os.kill(os.getpid(), signal.SIGINT)
            reached.append(True)

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert reached == [True]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_while_gmsh_meshes_is_not_lost_and_the_next_mesh_is_made(monkeypatch):
    generate = gmsh.model.mesh.generate

    def interrupted(dimension):
        os.kill(os.getpid(), signal.SIGINT)
        generate(dimension)

    monkeypatch.setattr(gmsh.model.mesh, "generate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        half_disc(
            "body", SurfaceGrading(inner=0.6, outer=1.1, size=0.12, edge_size=0.05, radius=6.0)
        )
    assert not gmsh.isInitialized()
    monkeypatch.undo()
    half_disc("body", SurfaceGrading(inner=0.6, outer=1.1, size=0.12, edge_size=0.05, radius=6.0))


def test_surface_elements_grow_from_the_zone_of_the_edges_inwards() -> None:
    """By 0.2 of the distance, up to the larger size."""
    grading = SurfaceGrading(inner=0.6, outer=1.1, size=0.04, edge_size=0.005, growth=0.2)
    points = surface_points(grading)
    sizes = np.diff(points)
    assert 0.6 in points
    assert points[-1] == 1.1
    ratios = sizes[:-1] / sizes[1:]
    assert ratios.max() < 1.25
    assert grading.size_at_middle == sizes[0] == pytest.approx(0.04, rel=0.1)
    distance = grading.inner - points[1:-1]
    inside = distance > 1e-12
    assert np.all(sizes[:-1][inside] <= 0.005 + 0.2 * (distance[inside] + 0.005) + 1e-12)
    even = surface_points(dataclasses.replace(grading, growth=math.inf))
    assert np.ptp(np.diff(even)[even[1:] < 0.6]) < 1e-12
