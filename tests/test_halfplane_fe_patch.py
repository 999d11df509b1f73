"""Patch tests of the contact coupling: uniform pressure, uniform stick shear and uniform sliding pass exactly.

The half-disc can't carry a uniform stress (its arc follows the half-plane), so the test takes it apart: the nodal weights are the
consistent forces of a uniform traction on the real meshes, and two periodic blocks, which can carry one, are coupled by the
engine's own interface and solved by its own active set.
"""

import dataclasses
import functools

import numpy as np
import pytest
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity

from halfplane_fe.contact import ContactProblem, untouched
from halfplane_fe.elasticity import CondensedBody, condense
from halfplane_fe.interface import couple
from halfplane_fe.systems import Layer
from meshes import BodyMesh, SurfaceGrading, half_disc
from scenes import Elastic, SurfaceState

STEEL, SOFT = Elastic(young_modulus=2.0, poisson_ratio=0.3), Elastic(young_modulus=0.7, poisson_ratio=0.1)
GRADING = SurfaceGrading(inner=0.5, outer=1.1, size=0.2, edge_size=0.1, radius=4.0)


def element(order):
    return skfem.ElementVector(skfem.ElementTriP2() if order == 2 else skfem.ElementTriP1())


# ------------------------------------------------------------------------------------------------- the real, unstructured mesh
def linear_field(places, pressure, shear, material):
    """Displacement (2, n) of the uniform stress syy = -pressure, sxy = shear, sxx = 0 in plane strain."""
    young, nu = material.young_modulus, material.poisson_ratio
    across, along = (1 - nu**2) / young, nu * (1 + nu) / young
    x, y = places
    return np.stack([along * pressure * x + 2 * (1 + nu) / young * shear * y, -across * pressure * y])


def patch_error(order, weights, pressure, shear):
    """The body held at its linear field on arc and free surface, `weights` times traction on the contact: distance from linear."""
    body = half_disc("body", GRADING, 0.3, order)
    basis = skfem.Basis(body.mesh, element(order), intorder=2 * order)
    stiffness = linear_elasticity(*lame_parameters(2.0, 0.3)).assemble(basis)
    exact, load, contact = np.empty(basis.N), np.zeros(basis.N), basis.get_dofs("contact")
    for component, (name, traction) in enumerate((("u^1", shear), ("u^2", -pressure))):
        dofs = basis.get_dofs(elements=True).all([name])
        exact[dofs] = linear_field(basis.doflocs[:, dofs], pressure, shear, STEEL)[component]
        loaded = contact.all([name])
        load[loaded[np.argsort(basis.doflocs[0, loaded])]] = weights * traction
    held = np.union1d(basis.get_dofs("far_field").all(), basis.get_dofs("free").all())
    found = skfem.solve(*skfem.condense(stiffness, load, x=exact, D=held))
    return np.abs(found - exact).max() / np.abs(exact).max()


@functools.cache
def half_disc_side(order):
    return condense(half_disc("body", GRADING, 0.3, order), STEEL, 1.0)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("pressure", "shear"), [(1.0, 0.0), (0.0, 1.0), (2.0, -0.6)])
def test_nodal_weights_carry_a_uniform_traction_exactly(order, pressure, shear):
    assert patch_error(order, half_disc_side(order).weights, pressure, shear) < 1e-12


def test_weights_by_distance_would_fail_that_test():
    """Half of the distance between a node's neighbours is right for linear elements, and wrong for quadratic ones."""
    for order, fails in ((1, False), (2, True)):
        x = half_disc_side(order).x
        by_neighbours = np.convolve(np.diff(x, prepend=x[0], append=x[-1]), [0.5, 0.5], mode="valid")
        assert (patch_error(order, by_neighbours, 1.0, 0.0) > 1e-3) == fails


# ------------------------------------------------------------------------------------------------------- two periodic blocks
WIDTH = 2.0


@functools.cache
def block(material, height, order):
    """A block y <= 0, held at its bottom and periodic along x, condensed to its top nodes as `condense` does a half-disc."""
    even = np.linspace(0, WIDTH, 9)
    mesh = skfem.MeshTri.init_tensor(even + 0.05 * np.sin(np.pi * even), np.linspace(-height, 0, 4))
    basis = skfem.Basis(mesh, element(order), intorder=2 * order)
    stiffness = linear_elasticity(*lame_parameters(material.young_modulus, material.poisson_ratio)).assemble(basis).toarray()
    x, y = basis.doflocs
    vertical = np.isin(np.arange(basis.N), basis.get_dofs(elements=True).all(["u^2"]))
    left, right = np.flatnonzero(x == 0), np.flatnonzero(x == WIDTH)
    alike = (y[right][:, None] == y[left]) & (vertical[right][:, None] == vertical[left])
    fold = np.eye(basis.N)
    fold[right] = fold[left[alike.argmax(axis=1)]]  # the right side is the left side
    top = [np.flatnonzero((y == 0) & (x < WIDTH) & (vertical == i)) for i in (False, True)]
    top = np.array([dofs[np.argsort(x[dofs])] for dofs in top])
    facets = skfem.FacetBasis(mesh, element(order), facets=mesh.facets_satisfying(lambda place: place[1] == 0), intorder=4)
    traction = fold.T @ skfem.LinearForm(lambda v, w: v[0] + 0 * w.x[0]).assemble(facets)
    free = np.flatnonzero((x < WIDTH) & (y > -height))
    inverse = np.zeros((basis.N, basis.N))
    inverse[np.ix_(free, free)] = np.linalg.inv((fold.T @ stiffness @ fold)[np.ix_(free, free)])
    n, flat = top.shape[1], top.ravel()
    compliance = inverse[np.ix_(flat, flat)].reshape(2, n, 2, n)
    return CondensedBody(BodyMesh("block", mesh, GRADING, {}), material, x[top[0]], 0 * x[top[0]], traction[top[0]], compliance)


def pair(order, upper=SOFT):
    return couple(block(STEEL, 1.0, order), block(upper, 1.0 if upper is STEEL else 0.6, order))


def problem(order, upper=SOFT, friction=0.4):
    interface = pair(order, upper)
    zero = np.zeros_like(interface.x)
    return ContactProblem(interface, zero, friction, Layer(zero, zero))


def compliances(upper):
    """Displacement of the two tops under unit uniform pressure (no strain across) and under unit shear."""
    normal = tangential = 0.0
    for material, height in ((STEEL, 1.0), (upper, 1.0 if upper is STEEL else 0.6)):
        young, nu = material.young_modulus, material.poisson_ratio
        normal += height * (1 + nu) * (1 - 2 * nu) / (young * (1 - nu))
        tangential += height * 2 * (1 + nu) / young
    return normal, tangential


EVERY = pytest.mark.parametrize(("order", "upper"), [(1, SOFT), (2, SOFT), (2, STEEL)], ids=["linear", "quadratic", "like bodies"])


@EVERY
@pytest.mark.parametrize(
    "share", [0.0, 0.5, -0.5, 1 - 1e-9, -1 + 1e-9], ids=["pressed", "stick", "stick back", "slide", "slide back"]
)
def test_uniform_tractions_pass_between_two_blocks(order, upper, share):
    """Up to the brink of sliding, q = +-f p at every node, pressure and shear are uniform and no node moves on the other side."""
    contact = problem(order, upper)
    pressure, shear = 1.5, share * 0.4 * 1.5
    state, _ = contact.equilibrium(untouched(contact.height, 0.0), 1.0, (pressure * WIDTH, shear * WIDTH))
    weights = contact.interface.weights
    np.testing.assert_allclose(weights.sum(), WIDTH, rtol=1e-14)
    np.testing.assert_allclose(state.pressure / weights, pressure, rtol=1e-11)
    np.testing.assert_allclose(state.shear / weights, shear, atol=1e-11)
    normal, tangential = compliances(upper)
    assert state.approach == pytest.approx(normal * pressure, rel=1e-11)
    assert state.shift == pytest.approx(tangential * shear, rel=1e-11, abs=1e-12)
    np.testing.assert_allclose(state.gap, 0.0, atol=1e-11)
    np.testing.assert_allclose(state.slip, 0.0, atol=1e-11)
    assert np.all(state.state == SurfaceState.STICK)


@pytest.mark.parametrize("name", ["shear goes out as pressure", "upper body not turned over"])
def test_that_test_sees_a_wrong_coupling(name):
    """Planted: tangential compliance in the normal one's place; an upper body whose share is taken away instead of added."""
    contact = problem(2)
    interface = contact.interface
    lower, upper = block(STEEL, 1.0, 2), block(SOFT, 0.6, 2)
    wrong = interface.tangential if "shear" in name else lower.compliance[1, :, 1, :] - 0.1 * upper.compliance[1, :, 1, :]
    planted = dataclasses.replace(interface, normal=wrong)
    zero = np.zeros_like(interface.x)
    state, _ = ContactProblem(planted, zero, 0.4, Layer(zero, zero)).equilibrium(untouched(zero, 0.0), 1.0, (WIDTH, 0.0))
    assert state.approach != pytest.approx(compliances(SOFT)[0], rel=1e-3)


def test_coupling_is_the_difference_of_the_two_bodies_and_none_for_like_ones():
    """Squeezed material creeps sideways: a linear traction moves the faces along x by the difference of the two blocks."""
    interface = pair(2)
    lower, upper = block(STEEL, 1.0, 2), block(SOFT, 0.6, 2)
    np.testing.assert_allclose(interface.coupling, lower.compliance[0, :, 1, :] - upper.compliance[0, :, 1, :], atol=1e-14)
    assert np.abs(interface.coupling).max() > 1e-3
    assert pair(2, STEEL).coupling is None
