"""Supports of blocks and pads: uniform states exact to rounding, no rigid motion left, a positive definite compliance."""

import dataclasses
import functools
import itertools

import numpy as np
import pytest

from halfplane_fe.elasticity import condense, displacement_fields
from halfplane_fe.interface import check_supports
from meshes import SurfaceGrading, solid
from scenes import Block, Cylinder, Elastic, Hertz, InputError, Pad, Scene, load_scene

WIDTH, HEIGHT, PRESSURE = 4.0, 3.0, 1.5
FACE = Hertz(radius=6.0)
MATERIALS = {"steel": Elastic(young_modulus=2.0, poisson_ratio=0.3), "rubber": Elastic(young_modulus=2.0, poisson_ratio=0.49)}
KINDS = tuple(itertools.product((1, 2), ("triangles", "quadrilaterals")))
EVERY = pytest.mark.parametrize(("order", "cells"), KINDS)
GRADING = SurfaceGrading(0.0, 1.0, 0.2, 0.2)


@functools.cache
def block(base, sides, order, cells):
    """A block whose whole face is named contact, so that the whole of it can be loaded."""
    shape = Block(width=WIDTH, height=HEIGHT, base=base, sides=sides)
    body = solid("lower", shape, FACE, GRADING, 0.5, order, cells)
    names = dict(body.mesh.boundaries)
    names["contact"] = np.union1d(names["contact"], names.pop("free"))
    return dataclasses.replace(body, mesh=body.mesh.with_boundaries(names))


def pressed(base, sides, order, cells, material):
    """Places (2, n), displacement (2, n) of every node under a uniform pressure on the whole face, and the mixed tension."""
    condensed = condense(block(base, sides, order, cells), material, 1.0)
    forces = np.stack([0 * condensed.weights, -PRESSURE * condensed.weights])[..., None]
    basis, displacements, tension = displacement_fields(condensed, forces, 1.0)
    along = basis.get_dofs(elements=True).all(["u^1"]), basis.get_dofs(elements=True).all(["u^2"])
    return basis.doflocs[:, along[0]], np.stack([displacements[dofs, 0] for dofs in along]), tension[:, 0]


def material_for(order, name):
    """Linear elements are refused above nu = 0.45."""
    return MATERIALS[name if order == 2 else "steel"]


@pytest.mark.parametrize("name", MATERIALS)
@EVERY
def test_on_rollers_a_uniform_pressure_gives_the_plane_strain_solution(order, cells, name):
    """syy = -p, sxx = 0: the block gets shorter by p (1 - nu^2)/E and wider by nu/(1 - nu) of that."""
    material = material_for(order, name)
    (x, y), (u_x, u_y), tension = pressed("rollers", "free", order, cells, material)
    nu = material.poisson_ratio
    shortening = PRESSURE * (1 - nu**2) / material.young_modulus
    np.testing.assert_allclose(u_y, -shortening * (y + HEIGHT), rtol=0, atol=1e-12 * HEIGHT)
    np.testing.assert_allclose(u_x, nu / (1 - nu) * shortening * x, rtol=0, atol=1e-12 * HEIGHT)
    if name == "rubber" and order == 2:  # what of Lame's lambda goes through the pressure of its own, times div u
        shear_modulus = material.young_modulus / (2 * (1 + nu))
        rest = 2 * shear_modulus * nu / (1 - 2 * nu) - 2 * shear_modulus
        np.testing.assert_allclose(tension, -rest * shortening * (1 - nu / (1 - nu)), rtol=1e-10)


@pytest.mark.parametrize("base", ["rollers", "fixed"])
@pytest.mark.parametrize("name", MATERIALS)
@EVERY
def test_between_walls_the_modulus_is_the_oedometric_one(order, cells, name, base):
    """exx = 0: p (1 + nu) (1 - 2 nu) / (E (1 - nu)); and the base need not be smooth."""
    material = material_for(order, name)
    (_, y), (u_x, u_y), _ = pressed(base, "guided", order, cells, material)
    nu = material.poisson_ratio
    strain = PRESSURE * (1 + nu) * (1 - 2 * nu) / (material.young_modulus * (1 - nu))
    np.testing.assert_allclose(u_y, -strain * (y + HEIGHT), rtol=0, atol=1e-12 * HEIGHT)
    np.testing.assert_allclose(u_x, 0.0, rtol=0, atol=1e-12 * HEIGHT)


@EVERY
def test_a_fixed_base_lies_between_rollers_and_walls(order, cells):
    """The mean shortening: no side could be exchanged for another and go unseen."""
    mean = {}
    for base, sides in (("rollers", "free"), ("fixed", "free"), ("fixed", "guided")):
        (_, y), (_, u_y), _ = pressed(base, sides, order, cells, MATERIALS["steel"])
        mean[base, sides] = -float(u_y[y > -1e-9].mean())
    assert mean["rollers", "free"] > 1.01 * mean["fixed", "free"] > 1.02 * mean["fixed", "guided"]
    (x, y), (u_x, u_y), _ = pressed("fixed", "free", order, cells, MATERIALS["steel"])
    held = y < -HEIGHT * (1 - 1e-9)
    assert np.all(u_x[held] == 0)
    assert np.all(u_y[held] == 0)
    assert np.abs(u_x).max() > 0.05
    assert np.all(u_x[(np.abs(x) < 1e-12)] == pytest.approx(0.0, abs=1e-12))


SUPPORTED = {
    **{
        f"{kind.__name__}, {base}, {sides}": kind(width=WIDTH, height=HEIGHT, base=base, sides=sides)
        for kind in (Block, Pad)
        for base in ("fixed", "rollers")
        for sides in ("free", "guided")
    },
    "Cylinder": Cylinder(radius=6.0),
}


def condensed(shape, order, cells, size=0.1, growth=0.5):
    grading = SurfaceGrading(0.0, 1.0, size, size)
    return condense(solid("lower", shape, FACE, grading, growth, order, cells), MATERIALS["steel"], 1.0)


@pytest.mark.parametrize(("order", "cells"), [(1, "quadrilaterals"), (2, "triangles")])
@pytest.mark.parametrize("name", SUPPORTED)
def test_compliance_is_symmetric_and_positive_definite_and_no_rigid_motion_is_left(name, order, cells):
    """A rigid motion left over would be an infinite eigenvalue, a support too many on the face a zero."""
    body = condensed(SUPPORTED[name], order, cells)
    n = len(body.x)
    values = np.linalg.eigvalsh(body.compliance.reshape(2 * n, 2 * n))
    assert body.diagnostics["asymmetry"] < 1e-11
    assert body.diagnostics["residual"] < 1e-10
    assert values.min() > 0
    assert values.max() < 50 * n  # of the order of n (height/width)/E
    assert values.min() / values.max() > 1e-4
    if body.body.supports.get("sides") != "guided" and SUPPORTED[name].kind != "cylinder":
        assert body.body.supports == {"base": SUPPORTED[name].base}


@pytest.mark.parametrize("name", ["Block, rollers, free", "Pad, fixed, guided", "Cylinder"])
def test_mirror_images_give_mirror_images(name):
    """x -> -x takes a normal force's sideways displacement to its negative, and so on, to rounding."""
    compliance = condensed(SUPPORTED[name], 2, "triangles").compliance
    turned = compliance[:, ::-1, :, ::-1] * np.array([-1.0, 1.0])[:, None, None, None] * np.array([-1.0, 1.0])[:, None]
    np.testing.assert_allclose(turned, compliance, rtol=0, atol=1e-11 * np.abs(compliance).max())


def pushed(shape, order, cells, size, growth):
    """Work of a parabolic pressure and of a parabolic shear on the contact, (2,), and of their product."""
    body = condensed(shape, order, cells, size, growth)
    forces = (1 - np.square(body.x)) * body.weights
    return np.array([forces @ body.compliance[i, :, j, :] @ (forces * body.x ** (i != j)) for i, j in ((0, 0), (1, 1), (0, 1))])


# Relative errors of the finer mesh, linear and quadratic. The corners of a fixed base are singular and far from the fine elements.
FOUND = {"Block, rollers, guided": (3.2e-2, 1.4e-4), "Block, fixed, free": (3.9e-2, 3.1e-3), "Cylinder": (3.8e-2, 1.2e-3)}


@functools.cache
def finely(name):
    return pushed(SUPPORTED[name], 2, "quadrilaterals", 1 / 30, 0.1)


@EVERY
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] if "fixed" in name else []) for name in FOUND])
def test_triangles_and_quadrilaterals_come_to_the_same_answer(name, order, cells):
    """Both orders and both kinds against one fine mesh of quadratic quadrilaterals."""
    sizes = ((1 / 5, 0.5), (1 / 20, 0.2))
    coarse, fine = (np.abs(pushed(SUPPORTED[name], order, cells, *size) / finely(name) - 1).max() for size in sizes)
    assert fine < 1.5 * FOUND[name][order - 1]
    assert fine < coarse / 3


def test_a_moment_is_carried_by_every_support():
    """A tangential force far above the base: the block leans, and does not turn away."""
    for name in ("Block, fixed, free", "Block, fixed, guided", "Block, rollers, guided"):
        body = condensed(SUPPORTED[name], 2, "triangles")
        moved = body.compliance[0, :, 0, :] @ body.weights
        assert 0 < moved.max() < 100


SCENE = load_scene("hertz-paper")


def supported(base, sides, which="upper", like=SCENE):
    bodies = {which: Block(width=200.0, height=100.0, base=base, sides=sides)}
    return Scene.model_validate({**like.model_dump(), "bodies": bodies})


@pytest.mark.parametrize("which", ["lower", "upper"])
def test_a_body_that_nothing_holds_is_refused(which):
    with pytest.raises(InputError) as caught:
        check_supports(supported("rollers", "free", which), sheared=True)
    assert str(caught.value) == (
        f"bodies.{which}: nothing holds the block against the tangential load, it slides off: its base is on rollers and its sides "
        "are free; take base = 'fixed' or sides = 'guided'"
    )


@pytest.mark.parametrize(
    ("base", "sides", "sheared"), [("rollers", "free", False), ("rollers", "guided", True), ("fixed", "free", True)]
)
def test_bodies_that_are_held_pass(base, sides, sheared):
    check_supports(supported(base, sides), sheared=sheared)
