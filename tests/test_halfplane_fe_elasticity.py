"""One body condensed to its contact nodes: far field, supports, surface displacement of a
half-plane, orders, no locking.
"""

import dataclasses
import functools
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halfplane_fe
import semi_analytic
from halfplane_fe import elasticity
from halfplane_fe.elasticity import condense, displacement_fields
from halfplane_fe.far_field import surface_force_displacement, surface_force_traction
from meshes import MeshSettings, SurfaceGrading, half_disc, solid
from problems import (
    COARSE,
    FEW_STEPS,
    drawn_inwards,
    fe_run,
    hertz_pressure,
    mindlin_dissipation,
    pressed_in,
)
from refusals import refused_for
from scenes import Block, Cylinder, Elastic, Hertz, Materials, Pad, load_scene
from tolerances import check, check_order

# --------------------------------------------- a point force on a half-plane, by finite differences


YOUNG = 3.0
POINT = 5.0
ratios = st.floats(-0.9, 0.49)
angles = st.floats(-math.pi / 2 + 0.05, math.pi / 2 - 0.05)
FORCES = {"along x": 0, "along y": 1}
EACH_FORCE = pytest.mark.parametrize("force", FORCES.values(), ids=FORCES.keys())


def displacement(x, y, nu, force, place=0.0, datum=POINT):
    """(2, n) at points (x, y) under a unit force."""
    x = np.atleast_1d(np.asarray(x, dtype=float))
    y = np.atleast_1d(np.asarray(y, dtype=float))
    return surface_force_displacement(x, y, np.array([place]), YOUNG, nu, datum)[:, :, force, 0]


def gradient(x, y, nu, force, step=1e-3):
    """(2, 2): d u_i / d x_j by central differences of fourth order."""
    columns = []
    for direction in np.eye(2):
        at = [
            displacement(x + k * step * direction[0], y + k * step * direction[1], nu, force)[:, 0]
            for k in (-2, -1, 1, 2)
        ]
        columns.append((at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * step))
    return np.array(columns).T


def stress(x, y, nu, force):
    """(2, 2) stress in plane strain."""
    grad = gradient(x, y, nu, force)
    strain = (grad + grad.T) / 2
    shear_modulus = YOUNG / (2 * (1 + nu))
    lame = YOUNG * nu / ((1 + nu) * (1 - 2 * nu))
    return lame * np.trace(strain) * np.eye(2) + 2 * shear_modulus * strain


@EACH_FORCE
@settings(max_examples=25)
@given(
    nu=ratios,
    angle=angles,
    cut=st.floats(0, 2 * math.pi),
    far=st.floats(0.2, 3),
    place=st.floats(-3, 3),
)
def test_a_point_force_is_in_equilibrium_with_its_tractions(force, nu, angle, cut, far, place):
    """Navier's equations, traction on any cut, a free surface, no movement at the datum, the same
    field elsewhere, mirror.
    """
    x = math.sin(angle)
    y = -math.cos(angle)
    h = 2e-3
    u = lambda i, j: displacement(x + i * h, y + j * h, nu, force)[:, 0]  # noqa: E731
    xx = (-u(2, 0) + 16 * u(1, 0) - 30 * u(0, 0) + 16 * u(-1, 0) - u(-2, 0)) / (12 * h**2)
    yy = (-u(0, 2) + 16 * u(0, 1) - 30 * u(0, 0) + 16 * u(0, -1) - u(0, -2)) / (12 * h**2)
    xy = (u(1, 1) - u(1, -1) - u(-1, 1) + u(-1, -1)) / (4 * h**2)
    rest = (1 - 2 * nu) * (xx + yy) + np.array([xx[0] + xy[1], xy[0] + yy[1]])
    assert np.abs(rest).max() < 1e-4 * np.abs([xx, yy, xy]).max() + 1e-6
    normal = np.array([math.cos(cut), math.sin(cut)])
    tractions = surface_force_traction(np.array([x]), np.array([y]), normal[:, None], np.zeros(1))[
        :, 0, force, 0
    ]
    np.testing.assert_allclose(tractions, stress(x, y, nu, force) @ normal, atol=1e-7)
    for side in (far, -far):
        # (2/pi) depth/x^2 at most
        assert np.abs(stress(side, -1e-2, nu, force)[:, 1]).max() < 0.7e-2 / far**2
        assert abs(displacement(side, 0.0, nu, force, datum=far)[force, 0]) < 1e-14
    moved = displacement(x, y, nu, force)
    np.testing.assert_allclose(
        displacement(x + place, y, nu, force, place=place), moved, rtol=1e-12, atol=1e-13
    )
    signs = [[1], [-1]] if force == 0 else [[-1], [1]]
    np.testing.assert_allclose(displacement(-x, y, nu, force), signs * moved, atol=1e-15)
    # Betti: u_y by a force along x is u_x by one along y, the other way.
    assert displacement(far, 0.0, nu, 0)[1, 0] == pytest.approx(
        displacement(0.0, 0.0, nu, 1, place=far)[0, 0], abs=1e-15
    )


# --------------------------------------------------------------------------- a half-disc, condensed


STEEL = Elastic(young_modulus=2.0, poisson_ratio=0.3)
DATUM = 7.0
END = 1.2


@functools.cache
def body(elements=16, order=2):
    """A half-disc with `elements` a unit of contact surface, the bulk refined with it."""
    return half_disc(
        "body",
        SurfaceGrading(0.0, END, 1 / elements, 1 / elements, 6.0),
        min(1.0, 2.4 / elements),
        order,
    )


@functools.cache
def condensed(elements=16, order=2, material=STEEL):
    return condense(body(elements, order), material, DATUM)


def uniform_errors(elements, order=2, material=STEEL):
    """Errors under a uniform traction, whose nodal forces are exact: (normal, tangential, cross),
    over the largest displacement.
    """
    condensed_body = condensed(elements, order=order, material=material)
    inside = np.abs(condensed_body.x) <= 1
    x = condensed_body.x[inside]
    young = material.young_modulus
    nu = material.poisson_ratio

    def by(i, j):
        """Displacement along i under a uniform load along j."""
        return (condensed_body.compliance[i, :, j, :] @ condensed_body.face_lengths)[inside]

    exact = pressed_in(x, END, young, nu, DATUM)
    across = drawn_inwards(x, young, nu)
    # By a pull along +y the surface comes out and is pushed apart; along x by shear it moves as far
    # as in by pressure.
    return [
        float(np.sqrt(np.mean(e**2)) / exact.max())
        for e in (by(1, 1) - exact, by(0, 0) - exact, by(0, 1) + across)
    ]


def halves(kind):
    """Meshes, materials and how many modes they have: bodies that are their own mirror image, and
    others.
    """
    rubber = Elastic(young_modulus=2.0, poisson_ratio=0.4999)
    if kind == "a node moved":
        mesh = body(8).mesh
        places = mesh.doflocs.copy()
        places[0, np.argmin(np.hypot(places[0] - 0.5, places[1] + 2))] += 1e-15
        return (
            dataclasses.replace(body(8), mesh=dataclasses.replace(mesh, doflocs=places)),
            STEEL,
            1,
        )
    if kind == "half-disc":
        return body(8), STEEL, 2
    if kind == "incompressible half-disc":
        return body(8), rubber, 2
    base, sides, order, cells = kind.split(", ")
    return block(base, sides, int(order), cells), rubber if order == "2" else STEEL, 2


@pytest.mark.parametrize(
    "kind",
    [
        "half-disc",
        "incompressible half-disc",
        "a node moved",
        "rollers, free, 2, triangles",
        "fixed, free, 2, quadrilaterals",
        "rollers, guided, 1, triangles",
        "fixed, guided, 1, quadrilaterals",
    ],
)
def test_both_modes_of_a_half_give_the_compliance_of_the_whole(kind, monkeypatch):
    """A body that is its own mirror image to the last bit is condensed on x >= 0; the answer is
    that of all its elements.
    """
    mesh, material, modes = halves(kind)
    by_half = condense(mesh, material, DATUM)
    assert by_half.diagnostics["sparse_factorisations"] == 1 + modes
    monkeypatch.setattr(elasticity, "_mirror_images", lambda _: None)
    compliance = condense(mesh, material, DATUM)
    assert compliance.diagnostics["sparse_factorisations"] == 2
    np.testing.assert_allclose(
        by_half.compliance,
        compliance.compliance,
        rtol=0,
        atol=2e-12 * np.abs(compliance.compliance).max(),
    )
    # and that of a solution which is not condensed at all; walls hold end nodes there
    if "guided" not in kind:
        forces = np.random.default_rng(1).standard_normal((2, len(compliance.x)))
        moved = displacement_fields(compliance, forces[..., None], DATUM)[1]
        expected = np.einsum("injm,jm->in", by_half.compliance, forces)
        moved_nodes = moved[elasticity.assemble(mesh, material).contact_dofs, 0]
        limit = 1e-6 if "far_field" in mesh.supports else 2e-11
        np.testing.assert_allclose(
            moved_nodes, expected, rtol=0, atol=limit * np.abs(expected).max()
        )


@pytest.mark.parametrize("nu", [-0.3, 0.49])
def test_surface_displacement_is_the_half_planes(nu):
    for error in uniform_errors(16, material=Elastic(young_modulus=2.0, poisson_ratio=nu)):
        check("compliance", error)


@pytest.mark.parametrize(
    ("order", "sizes", "name"), [(1, (4, 8, 16, 32), "linear"), (2, (4, 8, 16), "quadratic")]
)
def test_compliance_converges_at_the_order_of_its_elements(order, sizes, name):
    sequences = np.array([uniform_errors(elements, order) for elements in sizes]).T
    for sequence in sequences:
        check_order(f"compliance, {name} elements", [1 / n for n in sizes], sequence)


# ----------------------------------------------------------------------- blocks, pads and cylinders


WIDTH = 4.0
HEIGHT = 3.0
PRESSURE = 1.5
FACE = Hertz(radius=6.0)
MATERIALS = {
    "steel": Elastic(young_modulus=2.0, poisson_ratio=0.3),
    "rubber": Elastic(young_modulus=2.0, poisson_ratio=0.49),
}
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
    """Places (2, n), displacement (2, n) of every node under a uniform pressure on the whole face,
    and the mixed tension.
    """
    condensed = condense(block(base, sides, order, cells), material, 1.0)
    forces = np.stack([0 * condensed.face_lengths, -PRESSURE * condensed.face_lengths])[..., None]
    basis, displacements, tension = displacement_fields(condensed, forces, 1.0)
    along = basis.get_dofs(elements=True).all(["u^1"]), basis.get_dofs(elements=True).all(["u^2"])
    return (
        basis.doflocs[:, along[0]],
        np.stack([displacements[dofs, 0] for dofs in along]),
        tension[:, 0],
    )


@pytest.mark.parametrize(
    ("base", "sides"), [("rollers", "free"), ("rollers", "guided"), ("fixed", "guided")]
)
@pytest.mark.parametrize("name", MATERIALS)
@EVERY
def test_a_uniform_pressure_gives_the_plane_strain_solution(order, cells, name, base, sides):
    """On rollers shorter by p (1 - nu^2)/E, wider by nu/(1 - nu) of that; between walls p (1 +
    nu)(1 - 2 nu)/(E (1 - nu)).
    """
    # linear elements are refused above nu = 0.45
    material = MATERIALS[name if order == 2 else "steel"]
    (x, y), (u_x, u_y), tension = pressed(base, sides, order, cells, material)
    nu = material.poisson_ratio
    free = sides == "free"
    across = (1 - nu**2) if free else (1 + nu) * (1 - 2 * nu) / (1 - nu)
    strain = PRESSURE / material.young_modulus * across
    np.testing.assert_allclose(u_y, -strain * (y + HEIGHT), rtol=0, atol=1e-12 * HEIGHT)
    np.testing.assert_allclose(u_x, nu / (1 - nu) * strain * x * free, rtol=0, atol=1e-12 * HEIGHT)
    # what of Lame's lambda goes through the pressure of its own, times div u
    if name == "rubber" and order == 2 and free:
        shear_modulus = material.young_modulus / (2 * (1 + nu))
        rest = 2 * shear_modulus * nu / (1 - 2 * nu) - 2 * shear_modulus
        np.testing.assert_allclose(tension, -rest * strain * (1 - nu / (1 - nu)), rtol=1e-10)


SUPPORTED = {
    **{
        f"{kind.__name__}, {base}, {sides}": kind(
            width=WIDTH, height=HEIGHT, base=base, sides=sides
        )
        for kind in (Block, Pad)
        for base in ("fixed", "rollers")
        for sides in ("free", "guided")
    },
    "Cylinder": Cylinder(radius=6.0),
}


@pytest.mark.parametrize(("order", "cells"), [(1, "quadrilaterals"), (2, "triangles")])
@pytest.mark.parametrize("name", [*SUPPORTED, "half-disc"])
def test_compliance_is_symmetric_definite_and_its_own_mirror_image(name, order, cells):
    """Betti before the last digits are mended. A rigid motion left over would be an infinite
    eigenvalue, a support too many on the face a zero.
    """
    if name == "half-disc":
        condensed_body = condensed(order=order)
        # Simpson's rule is exact for cubic functions, the trapezoidal one for linear ones.
        for power, integral in enumerate((2 * END, 0.0, 2 * END**3 / 3, 0.0)[: 2 * order]):
            assert condensed_body.face_lengths @ condensed_body.x**power == pytest.approx(
                integral, abs=1e-12
            )
    else:
        body = solid(
            "lower", SUPPORTED[name], FACE, SurfaceGrading(0.0, 1.0, 0.1, 0.1), 0.5, order, cells
        )
        condensed_body = condense(body, MATERIALS["steel"], 1.0)
    n = len(condensed_body.x)
    signs = np.array([-1.0, 1.0])
    flat = condensed_body.compliance.reshape(2 * n, 2 * n)
    values = np.linalg.eigvalsh(flat)
    check("asymmetry", condensed_body.diagnostics["asymmetry"])
    assert condensed_body.diagnostics["residual"] < 1e-10
    np.testing.assert_array_equal(flat, flat.T)
    # of the order of n (height/width)/E
    assert 0 < 1e-4 * values.max() < values.min() < values.max() < 50 * n
    turned = (
        condensed_body.compliance[:, ::-1, :, ::-1] * signs[:, None, None, None] * signs[:, None]
    )
    np.testing.assert_allclose(turned, condensed_body.compliance, rtol=0, atol=1e-11 * flat.max())
    if (
        getattr(SUPPORTED.get(name), "sides", "free") == "guided"
        or condensed_body.body.supports.get("base") == "fixed"
    ):
        # a shear far above the base: it does not turn away
        assert 0 < (condensed_body.compliance[0, :, 0, :] @ condensed_body.face_lengths).max() < 100


# ---------------------------------------------------------------------------- nearly incompressible


def scene_at(poisson_ratio):
    """Cattaneo and Mindlin's cycle with the E* of the library's scene."""
    scene = load_scene("cattaneo-mindlin")
    plane = scene.material.lower.young_modulus / (1 - scene.material.lower.poisson_ratio**2)
    body = Elastic(young_modulus=plane * (1 - poisson_ratio**2), poisson_ratio=poisson_ratio)
    return scene.vary(material=Materials(lower=body, upper=body))


def errors_at(poisson_ratio):
    """Dissipation, and pressure at the end in L2 and in the worst of its inner nodes."""
    scene = scene_at(poisson_ratio)
    answer = halfplane_fe.solve(scene, COARSE, FEW_STEPS)
    body = scene.material.lower
    f = scene.friction.coefficient
    modulus = body.young_modulus / (1 - body.poisson_ratio**2) / 2
    load, amplitude = scene.load.cycle[0]
    exact = hertz_pressure(answer.x, load, scene.profile.radius, modulus)
    off = answer.pressure[-1] - exact
    weights = answer.condensed_bodies[0].face_lengths
    inner = np.abs(answer.x) < 0.5 * answer.contact_half_width[-1]
    return {
        "dissipation": abs(
            answer.dissipation / mindlin_dissipation(load, amplitude, f, modulus) - 1
        ),
        "pressure": np.sqrt(weights @ off**2 / (weights @ exact**2)),
        "rocking": np.abs(off[inner]).max() / exact.max(),
    }


def test_error_does_not_grow_with_nu_and_plain_elements_would_fail(monkeypatch):
    for quantity, error in errors_at(0.4999).items():
        check(f"incompressible {quantity}", error)
    monkeypatch.setattr(elasticity, "PLAIN_LAMBDA", np.inf)
    with pytest.raises(AssertionError, match="incompressible rocking"):
        check("incompressible rocking", errors_at(0.4999)["rocking"])


def test_linear_elements_are_refused_in_a_sentence():
    with refused_for("order = 1", "Poisson ratio of 0.499", "above 0.45"):
        halfplane_fe.solve(scene_at(0.499), MeshSettings(order=1), FEW_STEPS)
    body = half_disc("body", SurfaceGrading(0.0, 1.2, 1 / 8, 1 / 8, 6.0), 0.4, 1)
    assert condense(body, Elastic(young_modulus=1.0, poisson_ratio=0.45), 1.0).order == 1


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.4999])
def test_stress_of_the_elements_far_from_the_contact_is_that_of_theory(poisson_ratio):
    """Beyond three half-widths, where nodes have no stress of the tractions; of P and Q, all four
    components.
    """
    scene = scene_at(poisson_ratio)
    answer = fe_run(scene)
    step = int(np.argmax(answer.tangential_load))
    (snapshot,) = halfplane_fe.fields(answer, [answer.time[step]])
    p0 = answer.pressure[step].max()
    a = answer.contact_half_width[step]
    lower = snapshot.bodies[0]
    far = np.abs(np.hypot(*lower.points.T) / a - 4.2) < 0.8
    exact = semi_analytic.stress(scene, *lower.points[far].T, answer.time[step])[0]
    assert np.abs(lower.stress[far] - exact).max() < 5e-3 * p0
