"""Profiles given as Python functions: closed forms of Bessel functions, corners, flats, and what is refused."""

import mpmath as mp
import numpy as np
import pytest
from pydantic import ValidationError

from scenes import CallableProfile, Compound, FlatRounded, Hertz, InputError, PowerLaw, load_scene
from semi_analytic_truth import Truth, check_errors_are_honest, profile_contact, worst

COSH = Truth(1, mp.sinh, lambda a: mp.pi / 2 * a * mp.besseli(0, a))  # P = E* (pi/2) a I_1(a)
CORNER = Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=0.7)


def corner_slope(x):
    inside = np.clip(np.abs(x), 0, 0.7)
    return np.sign(x) * (inside + (np.abs(x) - inside) / 3)


@pytest.mark.parametrize("given", [{"height_function": lambda x: np.cosh(x) - 1}, {"slope_function": np.sinh}], ids=["h", "slope"])
def test_kernels_against_quadrature(given):
    """Measured 1e-12 from the height (a derivative is taken), 1e-14 from the slope."""
    contact = profile_contact(CallableProfile(extent=3.0, **given))
    limit = 1e-11 if "height_function" in given else 2e-13
    for name, error in worst(contact, COSH, (1e-6, 0.9, 2.9), moments=False).items():
        assert error < max(limit, 1e-11 * (name in ("pressure", "dissipation_kernel"))), name


def test_errors_are_honest():
    contact = profile_contact(CallableProfile(extent=3.0, slope_function=np.sinh))
    check_errors_are_honest(contact, COSH, (1e-3, 0.9, 2.9), 1e-10)


def test_a_corner_of_the_slope_is_found():
    contact = profile_contact(CallableProfile(slope_function=corner_slope, extent=5.0))
    exact = profile_contact(CORNER)
    assert contact.breaks == pytest.approx((0.7,), rel=1e-12)
    x = np.array([0.0, 0.3, 0.69, 0.71, 1.2, 3.0])
    for load in (0.1, 0.4, 3.0):
        np.testing.assert_allclose(contact.pressure(x, load), exact.pressure(x, load), rtol=1e-11, atol=1e-14)
        np.testing.assert_allclose(contact.slip_integral(x, load), exact.slip_integral(x, load), rtol=1e-11)
        assert float(contact.dissipation_kernel(load, 0.1 * load)) == pytest.approx(
            float(exact.dissipation_kernel(load, 0.1 * load)), rel=1e-11
        )


def test_a_flat_middle_is_found():
    def slope(x):
        return np.sign(x) * np.maximum(np.abs(x) - 0.5, 0) / 2

    contact = profile_contact(CallableProfile(slope_function=slope, extent=3.0))
    exact = profile_contact(FlatRounded(radius=2.0, flat_half_length=0.5))
    assert float(contact.half_width(0.0)) == pytest.approx(0.5, rel=1e-12)
    x, load = np.array([0.0, 0.49, 0.51, 1.0, 2.0]), np.array([[1e-3], [0.1], [0.6]])
    np.testing.assert_allclose(contact.pressure(x, load), exact.pressure(x, load), rtol=2e-9, atol=1e-12)
    np.testing.assert_allclose(contact.half_width(load), exact.half_width(load), rtol=1e-11)


@pytest.mark.parametrize("n", [1.5, 2.0, 3.2])
def test_powers_go_down_sixteen_decades(n):
    contact = profile_contact(CallableProfile(slope_function=lambda x: np.sign(x) * np.abs(x) ** (n - 1), extent=2.0))
    law = profile_contact(PowerLaw(exponent=n, length=1.0, rise=1 / n))
    load = float(law.load(1.99)) * 10.0 ** np.linspace(-16, 0, 33)
    np.testing.assert_allclose(contact.half_width(load), law.half_width(load), rtol=1e-12)
    np.testing.assert_allclose(contact.load(contact.half_width(load)), load, rtol=2e-14)


def test_a_function_of_single_numbers_will_do():
    def height(x):
        if abs(x) < 0.3:
            return x * x / 2
        return x * x / 2 + 0.0 * abs(x)

    profile = CallableProfile(height_function=height, extent=1.0)
    np.testing.assert_allclose(profile.height([0.2, 0.9, 1.5]), [0.02, 0.405, 0.5 + 0.5], rtol=1e-12)
    assert float(profile_contact(profile).half_width(0.1)) == pytest.approx(np.sqrt(0.4 / np.pi), rel=1e-11)


def test_height_and_slope_agree():
    one = CallableProfile(height_function=lambda x: np.cosh(x) - 1, extent=2.0)
    two = CallableProfile(slope_function=np.sinh, extent=2.0)
    x = np.array([-1.9, -0.4, 1e-3, 0.4, 1.3])
    np.testing.assert_allclose(one.height(x), two.height(x), rtol=1e-9)
    np.testing.assert_allclose(one.slope(np.abs(x)), np.sinh(np.abs(x)), rtol=1e-11)
    np.testing.assert_allclose(two.bend(np.abs(x)), np.abs(x) * np.cosh(x), rtol=1e-10)


REFUSED = [
    ({"slope_function": np.sign}, "no derivative|too rough"),
    ({"height_function": lambda x: x}, "not symmetric"),
    ({"height_function": lambda x: np.maximum(np.abs(x) - 0.1, 0)}, "no derivative"),
    ({"height_function": lambda x: -x * x}, "falls"),
    ({"height_function": lambda x: x * x * (1 - x * x / 3)}, r"falls at x = 1\.2"),
    ({"height_function": lambda x: np.floor(100 * x * x)}, "too rough|no derivative"),
    ({"height_function": lambda x: 0 * x}, "flat from end to end"),
    ({"height_function": lambda x: x * x, "slope_function": lambda x: 2 * x}, "not both"),
    ({}, "either height_function or slope_function"),
    ({"height_function": "x*x"}, "only be built in Python"),
]


@pytest.mark.parametrize(("given", "why"), REFUSED[1:])
def test_what_cannot_be_a_profile_is_refused(given, why):
    with pytest.raises(ValidationError, match=why):
        CallableProfile(extent=2.0, **given)


def test_a_sharp_wedge_is_a_profile():
    """Its slope jumps at 0 only, which is a tip."""
    contact = profile_contact(CallableProfile(slope_function=np.sign, extent=2.0))
    law = profile_contact(PowerLaw(exponent=1.0, length=1.0, rise=1.0))
    np.testing.assert_allclose(contact.pressure([0.1, 0.5], 1.0), law.pressure([0.1, 0.5], 1.0), rtol=1e-12)


def test_a_contact_wider_than_the_extent_is_refused():
    contact = profile_contact(CallableProfile(slope_function=lambda x: x, extent=1.0))
    with pytest.raises(InputError, match=r"extent = 1: the normal load 2 needs a wider contact"):
        contact.half_width(2.0)


def test_a_scene_with_a_function_cannot_be_written():
    scene = load_scene("hertz-paper").vary(profile=CallableProfile(slope_function=lambda x: x, extent=1.0))
    with pytest.raises(InputError, match="holds a Python function"):
        scene.model_dump_json()
    hertz = load_scene("hertz-paper").vary(profile=Hertz(radius=1.0))
    assert "hertz" in hertz.model_dump_json()
