"""One body condensed to its contact nodes: symmetry, equilibrium, datum, and the half-plane's own surface displacement."""

import functools
from importlib import import_module

import numpy as np
import pytest
from skfem.models.elasticity import lame_parameters, linear_elasticity

import halfplane_fe
from halfplane_fe.elasticity import condense, displacement_fields
from meshes import MeshSettings, SurfaceGrading, half_disc
from problems import drawn_inwards, pressed_in
from scenes import ConvergenceError, Elastic, Materials, load_scene
from tolerances import check, check_order

STEEL = Elastic(young_modulus=2.0, poisson_ratio=0.3)
DATUM, END = 7.0, 1.2


@functools.cache
def body(elements=16, radius=6.0, order=2):
    """A half-disc with `elements` a unit of contact surface, the bulk refined with it."""
    return half_disc("body", SurfaceGrading(0.0, END, 1 / elements, 1 / elements, radius), min(1.0, 2.4 / elements), order)


@functools.cache
def condensed(elements=16, radius=6.0, order=2, material=STEEL, datum=DATUM):
    return condense(body(elements, radius, order), material, datum)


def uniform_errors(elements, order=2, material=STEEL):
    """Errors under a uniform traction, whose nodal forces are exact: (normal, tangential, cross), over the largest displacement."""
    one = condensed(elements, order=order, material=material)
    inside = np.abs(one.x) <= 1
    x, young, nu = one.x[inside], material.young_modulus, material.poisson_ratio
    by = lambda i, j: (one.compliance[i, :, j, :] @ one.weights)[inside]  # noqa: E731
    exact, across = pressed_in(x, END, young, nu, DATUM), drawn_inwards(x, young, nu)
    # By a pull along +y the surface comes out and is pushed apart; along x by shear it moves as far as in by pressure.
    return [float(np.sqrt(np.mean(e**2)) / exact.max()) for e in (by(1, 1) - exact, by(0, 0) - exact, by(0, 1) + across)]


@pytest.mark.parametrize("order", [1, 2])
def test_compliance_is_symmetric_and_mirror_symmetric(order):
    one = condensed(order=order)
    n = len(one.x)
    flat = one.compliance.reshape(2 * n, 2 * n)
    np.testing.assert_array_equal(flat, flat.T)
    assert np.all(np.linalg.eigvalsh(flat) > 0)
    signs = np.array([-1.0, 1.0])
    mirrored = one.compliance[:, ::-1, :, ::-1] * signs[:, None, None, None] * signs[None, None, :, None]
    np.testing.assert_allclose(mirrored, one.compliance, atol=1e-11 * flat.max())
    np.testing.assert_array_equal(one.x, -one.x[::-1])


def test_compliance_comes_out_symmetric():
    """Betti's theorem, before the last digits are mended: a wrong traction, displacement or normal on the arc would break it."""
    check("asymmetry", condensed().diagnostics["asymmetry"])
    assert condensed().diagnostics["residual"] < 1e-12


def test_arc_holds_the_nodal_forces():
    """Reactions on the arc: minus the nodal forces, and no moment left."""
    one = condensed()
    rng = np.random.default_rng(3)
    forces = rng.normal(size=(2, len(one.x), 2))
    basis, displacement, _ = displacement_fields(one, forces, DATUM)
    stiffness = linear_elasticity(*lame_parameters(2.0, 0.3)).assemble(basis)
    residual = stiffness @ displacement
    arc = basis.get_dofs("far_field")
    x_dofs, y_dofs = arc.all(["u^1"]), arc.all(["u^2"])
    np.testing.assert_allclose(residual[x_dofs].sum(axis=0), -forces[0].sum(axis=0), atol=1e-10)
    np.testing.assert_allclose(residual[y_dofs].sum(axis=0), -forces[1].sum(axis=0), atol=1e-10)
    places = basis.doflocs
    moment = (places[0, y_dofs] @ residual[y_dofs]) - (places[1, x_dofs] @ residual[x_dofs])
    np.testing.assert_allclose(moment, -(one.x @ forces[1]), atol=1e-10)


def test_fields_of_the_whole_body_are_those_of_the_compliance():
    one = condensed()
    forces = np.random.default_rng(4).normal(size=(2, len(one.x), 1))
    basis, displacement, _ = displacement_fields(one, forces, DATUM)
    contact = basis.get_dofs("contact")
    for component, name in enumerate(("u^1", "u^2")):
        dofs = contact.all([name])
        order = np.argsort(basis.doflocs[0, dofs])
        by_compliance = np.einsum("njk,jk->n", one.compliance[component], forces[:, :, 0])
        np.testing.assert_allclose(displacement[dofs[order], 0], by_compliance, atol=3e-6 * np.abs(by_compliance).max())


def test_other_datum_is_a_rigid_translation():
    """The arc moved as a whole moves the body as a whole, by 2 (1 - nu^2)/(pi E) ln 2 for each unit of force along it."""
    change = condensed(datum=2 * DATUM).compliance - condensed().compliance
    expected = 2 * (1 - 0.3**2) / (np.pi * 2.0) * np.log(2)
    for i in (0, 1):
        for j in (0, 1):
            np.testing.assert_allclose(change[i, :, j, :], expected if i == j else 0.0, atol=1e-11)


@pytest.mark.parametrize("nu", [-0.3, 0.0, 0.3, 0.49])
def test_surface_displacement_is_the_half_planes(nu):
    errors = uniform_errors(16, material=Elastic(young_modulus=2.0, poisson_ratio=nu))
    for error in errors:
        check("compliance", error)


@pytest.mark.parametrize(("order", "sizes", "name"), [(1, (4, 8, 16, 32), "linear"), (2, (4, 8, 16), "quadratic")])
def test_compliance_converges_at_the_order_of_its_elements(order, sizes, name):
    sequences = np.array([uniform_errors(elements, order) for elements in sizes]).T
    for sequence in sequences:
        check_order(f"compliance, {name} elements", [1 / n for n in sizes], sequence)


def test_weights_are_the_share_of_each_node():
    """Simpson's rule on each element: exact for cubic functions, so a traction linear in x keeps its force and its moment."""
    one = condensed()
    assert np.all(one.weights > 0)
    for power, integral in enumerate((2 * END, 0.0, 2 * END**3 / 3, 0.0)):
        assert one.weights @ one.x**power == pytest.approx(integral, abs=1e-12)
    linear = condensed(order=1)
    assert linear.weights @ np.ones_like(linear.x) == pytest.approx(2 * END, abs=1e-12)
    assert linear.weights @ linear.x == pytest.approx(0.0, abs=1e-12)


def test_softer_body_moves_more_in_proportion():
    soft = condensed(material=Elastic(young_modulus=0.5, poisson_ratio=0.3))
    np.testing.assert_allclose(soft.compliance, 4 * condensed().compliance, rtol=1e-9, atol=1e-12)


def test_like_bodies_are_condensed_once_and_unlike_ones_twice(monkeypatch):
    calls = []

    def counted(body, material, datum_length):
        calls.extend([material] if len(body.mesh.boundaries["contact"]) < 24 else [])  # not the solver's own coarse run, of 48
        return condense(body, material, datum_length)

    monkeypatch.setattr(import_module("halfplane_fe.store"), "condense", counted)
    scene = load_scene("hertz-normal")
    coarse = MeshSettings(element_size=1 / 6, edge_element_size=1 / 6, far_radius=5.0, growth=0.5)
    like = halfplane_fe.solve(scene, coarse)
    assert len(calls) == like.work.counts["condensations"] == 1
    assert like.condensed[0] is like.condensed[1]
    assert "condensations" in like.work.skipped
    soft = Materials(lower=scene.material.lower, upper=Elastic(young_modulus=70e3, poisson_ratio=0.33))
    calls.clear()
    unlike = halfplane_fe.solve(scene.vary(material=soft), coarse)
    assert len(calls) == unlike.work.counts["condensations"] == 2
    assert [material.young_modulus for material in calls] == [210e3, 70e3]
    assert "condensations" not in unlike.work.skipped


def second_moment(radius):
    """4 int p x^2 / (P a^2) of a Hertz contact, 1 on half-planes: a wrong far field bends p as a whole."""
    mesh = MeshSettings(element_size=1 / 16, edge_element_size=1 / 16, far_radius=radius, growth=0.05)
    answer = halfplane_fe.solve(load_scene("hertz-normal"), mesh)
    forces = answer.pressure[-1] * answer.condensed[0].weights
    return 4 * float(forces @ answer.x**2 / forces.sum())


def test_pressure_does_not_know_how_far_the_body_reaches():
    check("second moment of p, L = 5a against 20a", second_moment(5.0) - second_moment(20.0))


def test_that_test_sees_an_arc_that_knows_only_the_resultant(monkeypatch):
    elasticity = import_module("halfplane_fe.elasticity")
    exact = elasticity.arc_work
    monkeypatch.setattr(elasticity, "arc_work", lambda basis, facets, at, *rest: exact(basis, facets, 0 * at, *rest))
    with pytest.raises(ConvergenceError, match="differs from that of the mesh"):  # such loads do not balance
        second_moment(5.0)
    monkeypatch.setattr(elasticity, "LARGEST_ERROR", np.inf)
    with pytest.raises(AssertionError, match="second moment"):
        check("second moment of p, L = 5a against 20a", second_moment(5.0) - second_moment(20.0))
