"""Wedge with a rounded tip: 30 digits from inside the tip to 10^8 tips away, Hertz inside, the sharp wedge far outside."""

import mpmath as mp
import numpy as np
import pytest

from scenes import PowerLaw, Wedge
from semi_analytic.hertz import HertzContact
from semi_analytic_truth import Truth, check_close_pairs, profile_contact, worst

WEDGE = profile_contact(Wedge(tip_radius=2.0, tip_half_length=1.0))
TRUTH = Truth(1, lambda x: min(x, mp.mpf(1)) / 2, lambda a: a * (mp.asin(1 / a) if a > 1 else mp.pi / 2) / 2, (1.0,))


@pytest.mark.parametrize("a", [1e-3, 0.9, 1 + 1e-8, 1.1, 3.0, 1e8])
def test_kernels_against_quadrature(a):
    """Measured: p 2e-13 next to the edge, the others 2e-16; b/a from 1e-8 to 1 - 1e-8."""
    for name, error in worst(WEDGE, TRUTH, (a,), moments=a == 3.0).items():
        limit = {"pressure": 1e-12, "pressure_moment": 1e-12, "dissipation_kernel": 1e-11}.get(name, 3e-15)
        assert error < limit, name
    check_close_pairs(WEDGE, (a,), 1e-13)


def test_half_width_inverts_load_over_sixteen_decades():
    load = 10.0 ** np.linspace(-8, 8, 161)
    np.testing.assert_allclose(WEDGE.load(WEDGE.half_width(load)), load, rtol=3e-15)


def test_inside_the_tip_it_is_hertz():
    hertz = HertzContact(modulus=1.0, radius=2.0, datum_length=2.0)
    x = np.array([0.0, 0.2, 0.6, 0.9])
    for name in ("pressure", "slip_integral", "pressure_moment", "slip_integral_moment"):
        np.testing.assert_allclose(getattr(WEDGE, name)(x, 0.2), getattr(hertz, name)(x, 0.2), rtol=1e-13, atol=1e-16)


def test_far_from_the_tip_it_is_a_sharp_wedge():
    """The difference is the tip's: of the order (b/a)^2 of the pressure at x of the order a."""
    sharp = profile_contact(PowerLaw(exponent=1.0, length=1.0, rise=0.5))
    x = np.array([1e3, 5e5, 9e5])
    load = 0.5e6
    np.testing.assert_allclose(WEDGE.half_width(load), sharp.half_width(load), rtol=1e-12)
    np.testing.assert_allclose(WEDGE.pressure(x, load), sharp.pressure(x, load), rtol=1e-7)
    np.testing.assert_allclose(WEDGE.dissipation_kernel(load, 0.3 * load), sharp.dissipation_kernel(load, 0.3 * load), rtol=1e-10)


def test_height_is_the_initial_gap():
    profile = Wedge(tip_radius=2.0, tip_half_length=1.0)
    x = np.array([0.4, 1.0, 1.001, 7.0])
    np.testing.assert_allclose(2 / np.pi * WEDGE.slip_integral(x, 1e9), profile.height(x), rtol=1e-14)
