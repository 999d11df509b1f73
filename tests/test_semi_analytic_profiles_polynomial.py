"""Even polynomials: kernels against 30 digits, one term against the power law, refusal of profiles under which contacts split."""

import mpmath as mp
import numpy as np
import pytest

from scenes import EvenPolynomial, InputError, PowerLaw
from semi_analytic_truth import Truth, check_close_pairs, check_errors_are_honest, profile_contact, worst

CASES = [(0.5,), (0.0, 0.3), (0.5, 0.25, 0.1), (1.0, -0.9, 0.5)]


def contact_and_truth(rises, length=2.0):
    contact = profile_contact(EvenPolynomial(length=length, rises=rises))
    scale = mp.mpf(length)

    def angle(n):
        return mp.sqrt(mp.pi) / 2 * mp.gamma(mp.mpf(n + 1) / 2) / mp.gamma(mp.mpf(n) / 2 + 1)

    terms = [(2 * k + 2, (2 * k + 2) * mp.mpf(c)) for k, c in enumerate(rises)]
    factors = [(n, c, angle(n)) for n, c in terms]
    return contact, Truth(
        1,
        lambda x: sum(c * x ** (n - 1) / scale**n for n, c in terms),
        lambda a: sum(c * n * each * a ** (n - 1) / scale**n for n, c, each in factors),
    )


@pytest.mark.parametrize("rises", CASES)
def test_kernels_against_quadrature(rises):
    """Measured: 8e-16, the slip area 6e-12 where a last digit of a counts a thousand times."""
    contact, truth = contact_and_truth(rises)
    for name, error in worst(contact, truth, (1e-8, 0.7, 40.0)).items():
        assert error < (3e-11 if name == "dissipation_kernel" else 4e-14), name
    check_close_pairs(contact, (1e-8, 0.7, 2.0, 40.0), 1e-13)
    check_errors_are_honest(contact, truth, (0.7, 40.0), 1e-10)


@pytest.mark.parametrize("rises", CASES)
def test_half_width_inverts_load_over_sixteen_decades(rises):
    contact, _ = contact_and_truth(rises)
    load = 10.0 ** np.linspace(-8, 8, 161)
    np.testing.assert_allclose(contact.load(contact.half_width(load)), load, rtol=4e-15)


@pytest.mark.parametrize("k", [1, 2, 5])
def test_one_term_is_the_power_law(k):
    one = profile_contact(EvenPolynomial(length=2.0, rises=(*[0.0] * (k - 1), 0.5)))
    law = profile_contact(PowerLaw(exponent=2.0 * k, length=2.0, rise=0.5))
    x, load = np.array([0.0, 0.2, 0.9, 2.5]), 0.4
    for name in ("pressure", "pressure_moment", "slip_integral", "slip_integral_moment"):
        np.testing.assert_allclose(getattr(one, name)(x, load), getattr(law, name)(x, load), rtol=1e-12, atol=1e-16)
    for name in ("half_width", "log_distance", "log_moment"):
        assert float(getattr(one, name)(load)) == pytest.approx(float(getattr(law, name)(load)), rel=1e-14)
    assert float(one.dissipation_kernel(load, 0.1)) == pytest.approx(float(law.dissipation_kernel(load, 0.1)), rel=1e-12)


def test_a_rising_profile_under_which_the_contact_splits_is_refused():
    """h' >= 0 everywhere, but not dP/da: 1, 2 - eps, 1 shares of x, x^3, x^5."""
    profile = EvenPolynomial(length=1.0, rises=(0.5, -0.49, 1 / 6))
    with pytest.raises(InputError, match=r"split near a half-width of"):
        profile_contact(profile)


@pytest.mark.parametrize("rises", [(0.5, -0.6, 1 / 6), (-0.1, 1.0), (0.5, -0.1), (0.0, 0.0)])
def test_a_falling_or_flat_profile_is_refused(rises):
    with pytest.raises(ValueError, match=r"must rise|must be positive"):
        EvenPolynomial(length=1.0, rises=rises)


def test_height_is_the_initial_gap():
    profile = EvenPolynomial(length=2.0, rises=(0.5, 0.25, 0.1))
    x = np.array([0.4, 1.0, 7.0])
    np.testing.assert_allclose(2 / np.pi * profile_contact(profile).slip_integral(x, 1e9), profile.height(x), rtol=1e-13)


def test_slip_area_where_p_hardly_grows():
    """Across a half-width at which dP/da is nearly 0 twelve nodes of Gauss' rule left 1e-7 of Lam, and did not say so."""
    contact = profile_contact(EvenPolynomial(length=1.0, rises=(1.0, -1.0, 0.43)))
    node, weight = np.polynomial.legendre.leggauss(12)
    for half in np.linspace(0.4, 1.4, 41):
        load = float(contact.load(half))
        for part in (1e-3, 0.019, 0.03, 0.1, 0.25):
            front = float(contact.half_width(load * (1 - part)))
            marks = np.linspace(front, half, 201)
            step = np.diff(marks)[:, None] / 2
            a = marks[:-1, None] + step * (1 + node)
            exact = np.sum(step * weight * contact.stiffness(a) * np.log1p((a - front) / front))
            assert float(contact.dissipation_kernel(load, part * load)) == pytest.approx(exact, rel=2e-11), (half, part)
