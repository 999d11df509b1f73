"""Compound curvature: every kernel against 30 digits on both sides of the corner, and the limits Hertz, flat and rounded, wedge."""

import mpmath as mp
import numpy as np
import pytest

from scenes import Compound
from semi_analytic.hertz import HertzContact
from semi_analytic.profiles import flat_and_rounded, two_curvatures
from semi_analytic.punch_superposition import PunchSuperposition
from semi_analytic_truth import Truth, check_close_pairs, check_errors_are_honest, profile_contact, worst

METHODS = ("pressure", "pressure_moment", "slip_integral", "slip_integral_moment")
# Measured 7e-14 of p and 8e-16 of the rest; where a last digit of a counts a thousand times, as in Lam, 5e-13.
LIMIT = {"pressure": 1e-12, "pressure_moment": 1e-12, "dissipation_kernel": 1e-11}


def contact_and_truth(inner, outer, b=1.0):
    contact = profile_contact(Compound(inner_radius=inner, outer_radius=outer, inner_half_length=b))
    one, two, corner = mp.mpf(inner), mp.mpf(outer), mp.mpf(b)

    def slope(x):
        return min(x, corner) / one + max(x - corner, 0) / two

    def rate(a):
        return a * (mp.asin(corner / a) / one + mp.acos(corner / a) / two) if a > corner else mp.pi / 2 * a / one

    return contact, Truth(1, slope, rate, (b,))


@pytest.mark.parametrize(("inner", "outer"), [(1.0, 3.0), (3.0, 0.5), (1.0, 1e4)])
def test_kernels_against_quadrature(inner, outer):
    contact, truth = contact_and_truth(inner, outer)
    found = worst(contact, truth, (1e-3, 0.9, 1 + 1e-5, 1.1, 3.0, 1e4), moments=(inner, outer) == (1.0, 3.0))
    for name, error in found.items():
        assert error < LIMIT.get(name, 2e-14), name
    check_close_pairs(contact, (1e-3, 0.9, 1.1, 3.0), 1e-13)


def test_quadratures_are_honest():
    contact, truth = contact_and_truth(1.0, 3.0)
    check_errors_are_honest(contact, truth, (0.9, 1.1, 3.0, 1e3), 1e-10)


@pytest.mark.parametrize("ratio", [1e-8, 1e-3, 1 - 1e-8])
def test_half_width_inverts_load_next_to_the_corner_and_far_from_it(ratio):
    """b/a = ratio: a itself to rounding."""
    for outer in (3.0, 0.2):
        contact, _ = contact_and_truth(1.0, outer, b=ratio)
        assert float(contact.half_width(contact.load(1.0))) == pytest.approx(1.0, rel=2e-15)


@pytest.mark.parametrize("outer", [1e-3, 0.3, 5.0, 1e6])
def test_half_width_inverts_load_over_sixteen_decades(outer):
    contact, _ = contact_and_truth(1.0, outer)
    load = 10.0 ** np.linspace(-8, 8, 321)
    np.testing.assert_allclose(contact.load(contact.half_width(load)), load, rtol=1e-14 if outer >= 0.3 else 1e-12)
    assert np.all(np.diff(contact.half_width(load)) > 0)


def test_equal_radii_are_hertz():
    same, _ = contact_and_truth(2.0, 2.0)
    hertz = HertzContact(modulus=1.0, radius=2.0, datum_length=2.0)
    x = np.array([0.0, 0.3, 0.999, 1.0, 1.7, 4.0])
    for load in (0.05, 0.4, 3.0):
        for name in METHODS:
            np.testing.assert_allclose(getattr(same, name)(x, load), getattr(hertz, name)(x, load), rtol=3e-13, atol=1e-14)
        assert float(same.half_width(load)) == pytest.approx(float(hertz.half_width(load)), rel=1e-15)
        assert float(same.log_distance(load)) == pytest.approx(float(hertz.log_distance(load)), rel=1e-14)
        assert float(same.dissipation_kernel(load, 0.1 * load)) == pytest.approx(
            float(hertz.dissipation_kernel(load, 0.1 * load)), rel=1e-12
        )


def test_a_flat_middle_is_flat_and_rounded():
    nearly = PunchSuperposition(two_curvatures(1.0, inner_radius=1e14, outer_radius=1.0, inner_half_length=1.0), 1.0)
    flat = PunchSuperposition(flat_and_rounded(1.0, 1.0, 1.0), 1.0)
    x = np.array([0.0, 0.5, 0.999, 1.0, 1.2, 2.5])
    for load in (1e-3, 0.3, 20.0):
        for name in METHODS:
            np.testing.assert_allclose(getattr(nearly, name)(x, load), getattr(flat, name)(x, load), rtol=1e-8, atol=1e-12)
        assert float(nearly.half_width(load)) == pytest.approx(float(flat.half_width(load)), rel=1e-12)


def test_a_corner_out_of_reach_is_hertz_with_the_inner_radius():
    contact, _ = contact_and_truth(2.0, 0.1, b=50.0)
    hertz = HertzContact(modulus=1.0, radius=2.0, datum_length=0.1)
    x = np.array([0.0, 0.5, 1.1])
    np.testing.assert_allclose(contact.pressure(x, 0.3), hertz.pressure(x, 0.3), rtol=1e-14)
    np.testing.assert_allclose(contact.dissipation_kernel(0.3, 0.1), hertz.dissipation_kernel(0.3, 0.1), rtol=1e-13)


def test_height_is_the_initial_gap():
    profile = Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=1.0)
    contact = profile_contact(profile)
    x = np.array([0.4, 1.0, 1.001, 7.0])
    np.testing.assert_allclose(2 / np.pi * contact.slip_integral(x, 1e9), profile.height(x), rtol=1e-14)
    np.testing.assert_allclose(np.gradient(profile.height(np.linspace(1, 2, 5)), 0.25)[1:-1], 1 + np.array([0.25, 0.5, 0.75]) / 3)


def test_pressure_carries_the_load():
    contact, _ = contact_and_truth(1.0, 3.0)
    node, weight = np.polynomial.legendre.leggauss(200)
    angle = (node + 1) * np.pi / 4
    for load in (0.5, 3.0):
        half = float(contact.half_width(load))
        total = 2 * np.sum(weight * np.pi / 4 * half * np.cos(angle) * contact.pressure(half * np.sin(angle), load))
        assert total == pytest.approx(load, rel=1e-5)
        assert np.all(contact.pressure([1.0000001 * half, 9.0], load) == 0)
