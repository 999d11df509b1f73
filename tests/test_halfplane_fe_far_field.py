"""The point-force displacements on the arc: what a half-plane under a force must do, by finite differences."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfplane_fe.far_field import surface_force_displacement, surface_force_traction

YOUNG, DATUM = 3.0, 5.0
ratios = st.floats(-0.9, 0.49)
angles = st.floats(-math.pi / 2 + 0.05, math.pi / 2 - 0.05)
FORCES = {"along x": 0, "along y": 1}
EACH_FORCE = pytest.mark.parametrize("force", FORCES.values(), ids=FORCES.keys())


def displacement(x, y, nu, force, place=0.0, datum=DATUM):
    """(2, n) at points (x, y) under a unit force."""
    x, y = np.atleast_1d(np.asarray(x, dtype=float)), np.atleast_1d(np.asarray(y, dtype=float))
    return surface_force_displacement(x, y, np.array([place]), YOUNG, nu, datum)[:, :, force, 0]


def gradient(x, y, nu, force, step=1e-3):
    """(2, 2): d u_i / d x_j by central differences of fourth order."""
    columns = []
    for direction in np.eye(2):
        at = [displacement(x + k * step * direction[0], y + k * step * direction[1], nu, force)[:, 0] for k in (-2, -1, 1, 2)]
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
@given(nu=ratios, angle=angles)
def test_navier_equations(force, nu, angle):
    """(1 - 2 nu) laplace u + grad div u = 0 in the body, at distance 1."""
    x, y, h = math.sin(angle), -math.cos(angle), 2e-3
    u = lambda i, j: displacement(x + i * h, y + j * h, nu, force)[:, 0]  # noqa: E731
    xx = (-u(2, 0) + 16 * u(1, 0) - 30 * u(0, 0) + 16 * u(-1, 0) - u(-2, 0)) / (12 * h**2)
    yy = (-u(0, 2) + 16 * u(0, 1) - 30 * u(0, 0) + 16 * u(0, -1) - u(0, -2)) / (12 * h**2)
    xy = (u(1, 1) - u(1, -1) - u(-1, 1) + u(-1, -1)) / (4 * h**2)
    rest = (1 - 2 * nu) * (xx + yy) + np.array([xx[0] + xy[1], xy[0] + yy[1]])
    assert np.abs(rest).max() < 1e-4 * np.abs(xx).max() + 1e-6


@EACH_FORCE
@given(nu=ratios, x=st.floats(0.2, 3), right=st.booleans())
def test_surface_is_free_of_traction(force, nu, x, right):
    """Just inside the surface, where the differences may still look, no traction but (2/pi) depth/x^2 at most."""
    x = x if right else -x
    assert np.abs(stress(x, -1e-2, nu, force)[:, 1]).max() < 0.7e-2 / x**2


@EACH_FORCE
@given(nu=ratios, angle=angles, cut=st.floats(0, 2 * math.pi))
def test_traction_is_that_of_the_displacement(force, nu, angle, cut):
    """On a cut of any direction, whatever Poisson's ratio."""
    x, y, normal = math.sin(angle), -math.cos(angle), np.array([math.cos(cut), math.sin(cut)])
    found = surface_force_traction(np.array([x]), np.array([y]), normal[:, None], np.zeros(1))[:, 0, force, 0]
    np.testing.assert_allclose(found, stress(x, y, nu, force) @ normal, atol=1e-7)


@EACH_FORCE
@pytest.mark.parametrize("nu", [-0.4, 0.0, 0.3, 0.49])
@pytest.mark.parametrize("radius", [0.5, 2.0])
def test_resultant_on_any_arc_is_the_unit_force(force, nu, radius):
    """The traction on an arc, along the outward normal, holds the body against the force; no moment about the force."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total, moment = np.zeros(2), 0.0
    for angle, weight in zip(nodes * math.pi / 2, weights * math.pi / 2, strict=True):
        normal = np.array([math.sin(angle), -math.cos(angle)])
        traction = stress(radius * normal[0], radius * normal[1], nu, force) @ normal
        total += traction * weight * radius
        moment += (normal[0] * traction[1] - normal[1] * traction[0]) * weight * radius**2
    np.testing.assert_allclose(total, -np.eye(2)[force], atol=2e-6)
    assert abs(moment) < 2e-6


@EACH_FORCE
@given(nu=ratios, datum=st.floats(0.1, 100), right=st.booleans())
def test_surface_at_the_datum_does_not_move_along_the_force(force, nu, datum, right):
    x = datum if right else -datum
    assert abs(displacement(x, 0.0, nu, force, datum=datum)[force, 0]) < 1e-14


@EACH_FORCE
@given(nu=ratios, place=st.floats(-3, 3), angle=angles)
def test_force_elsewhere_is_the_same_field_elsewhere(force, nu, place, angle):
    x, y = 2 * math.sin(angle), -2 * math.cos(angle)
    np.testing.assert_allclose(
        displacement(x + place, y, nu, force, place=place), displacement(x, y, nu, force), rtol=1e-12, atol=1e-13
    )


@given(nu=ratios, angle=angles)
def test_mirror(nu, angle):
    """Under a force along x the mirrored point moves by (u_x, -u_y), under one along y by (-u_x, u_y)."""
    x, y = math.sin(angle), -math.cos(angle)
    for force, signs in ((0, [1, -1]), (1, [-1, 1])):
        here, there = displacement(x, y, nu, force)[:, 0], displacement(-x, y, nu, force)[:, 0]
        np.testing.assert_allclose(there, signs * here, atol=1e-15)


@given(nu=ratios, apart=st.floats(0.1, 4))
def test_betti(nu, apart):
    """Work of one force in the other's field is the same both ways: u_y by a force along x, and u_x by one along y."""
    first = displacement(apart, 0.0, nu, 0)[1, 0]
    second = displacement(0.0, 0.0, nu, 1, place=apart)[0, 0]
    assert first == pytest.approx(second, abs=1e-15)


def test_numbers_of_a_known_case():
    """Straight below a force pulling outward, depth r: u_y = c [1 - 2 (1-nu) ln(r/L)], c = 1/(2 pi G); and the pull lifts."""
    nu, r = 0.3, 2.0
    c = 1 / (2 * math.pi * YOUNG / (2 * (1 + nu)))
    u_x, u_y = displacement(0.0, -r, nu, 1)[:, 0]
    assert u_y == pytest.approx(c * (1 - 2 * (1 - nu) * math.log(r / DATUM)), rel=1e-14)
    assert u_x == 0.0
    # Pressed in by a force along -y the surface is drawn towards the force: (1 - 2 nu)/(4 G) each side.
    side = -displacement(1.0, 0.0, nu, 1)[0, 0]
    assert side == pytest.approx(-(1 - 2 * nu) * (1 + nu) / (2 * YOUNG), rel=1e-14)


@EACH_FORCE
@pytest.mark.parametrize("moments", [0, 1, 2, 3, 4])
def test_what_a_truncated_series_leaves_out_falls_with_the_next_power_of_the_place(force, moments):
    """Half the distance of the force from the centre leaves out 2^-(m+1) as much: on both sides of the order."""
    x, y = 5 * np.sin(np.linspace(-1.5, 1.5, 7)), -5 * np.cos(np.linspace(-1.5, 1.5, 7))
    places = np.array([0.2, 0.1])
    exact = surface_force_displacement(x, y, places, YOUNG, 0.3, DATUM)
    left_out = surface_force_displacement(x, y, places, YOUNG, 0.3, DATUM, moments=moments) - exact
    large, small = np.sqrt((left_out[:, :, force] ** 2).mean(axis=(0, 1)))
    assert math.log2(large / small) == pytest.approx(moments + 1, abs=0.1)


def test_resultants_alone_do_not_know_where_the_forces_are():
    at_once = surface_force_displacement(
        np.array([3.0]), np.array([-4.0]), np.array([-0.7, 0.0, 0.4]), YOUNG, 0.3, DATUM, moments=0
    )
    alone = surface_force_displacement(np.array([3.0]), np.array([-4.0]), np.array([0.0]), YOUNG, 0.3, DATUM)
    np.testing.assert_allclose(at_once, np.broadcast_to(alone, at_once.shape), atol=1e-15)
