"""Normal contact of each profile: closed forms against quadrature in 30 digits, inverses, limits."""

import tracemalloc

import mpmath as mp
import numpy as np
import pytest

from scenes import FlatRounded, InputError, Materials
from semi_analytic import solve
from semi_analytic.elasticity import composite_modulus, coupling_constant
from semi_analytic.hertz import HertzContact, log_excess
from semi_analytic.profiles import contact_of, flat_and_rounded, inverse_load_function
from semi_analytic.punch_superposition import PunchSuperposition
from semi_analytic_cases import UNIT, Elastic, make_scene, polygon

HERTZ = HertzContact(modulus=3.0, radius=2.0, datum_length=5.0)
FLAT = PunchSuperposition(flat_and_rounded(modulus=2.0, radius=1.0, flat_half_length=1.0), datum_length=5.0)  # E* b^2/(2 R) = 1
CONTACTS = pytest.mark.parametrize("contact", [HERTZ, FLAT], ids=["hertz", "flat_rounded"])


def integrate(function, begin, end):
    """30-digit quadrature with the ends graded."""
    cuts = [begin, *(begin + (end - begin) * mp.mpf(10) ** -k for k in range(9, 0, -1)), end]
    return mp.quad(function, cuts)


def law(contact, a):
    """dP/da: E* a arccos(b/a)/R, b = 0 for Hertz."""
    return mp.mpf(_bend(contact)) * a * mp.acos(min(contact.least / a, 1))


def _bend(contact):
    """E*/R."""
    return 1.5 if contact is HERTZ else 2.0


@CONTACTS
def test_load_is_the_integral_of_its_law(contact):
    first = contact.least
    for a in (1.3, 2.0, 40.0):
        exact = integrate(lambda alpha: law(contact, alpha), mp.mpf(first), mp.mpf(a))
        assert float(contact.load(a)) == pytest.approx(float(exact), rel=2e-15)


@CONTACTS
def test_half_width_inverts_load_over_sixteen_decades(contact):
    load = 10.0 ** np.linspace(-8, 8, 161)
    # On the flat face a itself keeps no more digits of a - b than a double leaves it: the advance of the edge keeps all.
    if contact is FLAT:
        np.testing.assert_allclose(contact.law.load(contact.law.advance(load)), load, rtol=4e-15)
    else:
        np.testing.assert_allclose(contact.load(contact.half_width(load)), load, rtol=1e-15)


@pytest.mark.parametrize("x", [0.0, 0.7, 0.999999, 1.0, 1.000001, 1.2, 1.9, 1.9999])
@CONTACTS
def test_pressure_is_the_pile_of_flat_punches(contact, x):
    x, a = mp.mpf(x), mp.mpf(2)
    first = max(x, mp.mpf(contact.least))
    low, high = mp.sqrt(first**2 - x**2), mp.sqrt(a**2 - x**2)

    def strip(w):
        alpha = mp.sqrt(x * x + w * w)
        return law(contact, alpha) / alpha / mp.pi if alpha else mp.mpf(0)

    exact = integrate(strip, low, high)
    assert float(contact.pressure(float(x), float(contact.load(2.0)))) == pytest.approx(float(exact), rel=3e-14)


@CONTACTS
def test_pressure_carries_the_load_and_vanishes_outside(contact):
    load = float(contact.load(2.0))
    angle = (np.polynomial.legendre.leggauss(400)[0] + 1) * np.pi / 4
    weight = np.polynomial.legendre.leggauss(400)[1] * np.pi / 4
    assert 2 * np.sum(weight * 2 * np.cos(angle) * contact.pressure(2 * np.sin(angle), load)) == pytest.approx(load, rel=1e-5)
    assert np.all(contact.pressure([2.0000001, 3.0], load) == 0)


@pytest.mark.parametrize("tau", [1e-4, 0.1, 0.299, 0.301, 1.0, 30.0, 1e6])
def test_flat_rounded_keeps_its_digits_at_any_depth(tau):
    """The centre pressure from b/a = 1e-6 up to 1 - 5e-9, and the load itself."""
    t = mp.mpf(tau)
    load = (1 + t * t) * mp.atan(t) - t
    assert float(inverse_load_function(float(load))) == pytest.approx(tau, rel=4e-15)
    exact = integrate(lambda s: 2 / mp.pi * s * mp.atan(s) / mp.sqrt(1 + s * s), mp.mpf(0), t)
    assert float(FLAT.pressure(0.0, float(load))) == pytest.approx(float(exact), rel=4e-15)


@pytest.mark.parametrize("tau", [1e-8, 1e-3, 0.299])
def test_pressure_under_a_flat_much_longer_than_its_rounded_edges(tau):
    """From the middle over the edge of the flat to that of the contact, x by g^2 = 1 - x^2 in units of tau."""
    share = np.array([1e8, 30.0, 2.0, 1.001, 0.999, 0.3, 1e-3, 1e-6, 0.0, -1e-6, -0.1, -0.9, -0.999999])
    x = np.sqrt(1 - np.minimum(share * np.abs(share) * tau**2, 1.0))
    with mp.workdps(40):
        load = float((1 + mp.mpf(tau) ** 2) * mp.atan(mp.mpf(tau)) - mp.mpf(tau))
    found = FLAT.pressure(x, load) * np.pi / 2  # E* b/(pi R) = 2/pi
    for place, value in zip(x.tolist(), found.tolist(), strict=True):
        if place >= FLAT.half_width(load):
            continue  # the last digit of a is more than the rounded edge has
        square = float((1 - mp.mpf(place)) * (1 + mp.mpf(place)))
        # A last digit of P counts from the edge of contact.
        digits = 1e-14 + 2e-16 / abs(1 + square / tau**2)
        # As a function of v, t = |g| sinh v or |g| cosh v: all of it smooth.
        with mp.workdps(40):
            t, g = mp.mpf(tau), mp.mpf(float(np.sqrt(abs(square))))
            if square > 0:
                exact = integrate(lambda v, g=g: mp.atan(g * mp.sinh(v)) * g * mp.sinh(v), mp.mpf(0), mp.asinh(t / g))
            elif square < 0:
                exact = integrate(lambda v, g=g: mp.atan(g * mp.cosh(v)) * g * mp.cosh(v), mp.mpf(0), mp.acosh(t / g))
            else:
                exact = t * mp.atan(t) - mp.log1p(t * t) / 2
        assert value == pytest.approx(float(exact), rel=digits, abs=0)


def test_a_long_flat_takes_no_more_memory_than_a_short_one():
    """A load that rounds a thousandth of a flat: 900 MB and 7 s before, at 193 nodes a point and instant."""
    load = polygon([(1e-9, 0.0)], [(1e-9, 3e-10), (1e-9, -3e-10)])
    scene = make_scene(load, 0.5).model_copy(update={"profile": FlatRounded(radius=1000.0, flat_half_length=1.0)})
    tracemalloc.start()
    try:
        solve(scene)
        assert tracemalloc.get_traced_memory()[1] < 1e8
    finally:
        tracemalloc.stop()


@CONTACTS
def test_moments_spread_and_logarithm_against_quadrature(contact):
    first, end = mp.mpf(contact.least), mp.mpf("1.7")
    load, x = float(contact.load(1.7)), mp.mpf("2.1")

    def total(kernel, moment):
        def integrand(a):
            if a == first:
                return mp.mpf(0)
            eta = mp.mpf(float(contact.load(float(a)))) if moment else 1
            return law(contact, a) * kernel(a) * eta

        return float(integrate(integrand, first, end))

    assert float(contact.slip_integral(2.1, load)) == pytest.approx(total(lambda a: mp.acosh(x / a), 0), rel=3e-15)
    assert float(contact.slip_integral_moment(2.1, load)) == pytest.approx(total(lambda a: mp.acosh(x / a), 1), rel=3e-15)
    assert float(contact.log_distance(load)) == pytest.approx(total(lambda a: mp.log(10 / a), 0), rel=3e-15)
    assert float(contact.log_moment(load)) == pytest.approx(total(lambda a: mp.log(10 / a), 1), rel=3e-15)


@CONTACTS
def test_spread_beyond_the_contact_edge_is_the_initial_gap(contact):
    """(A/pi) S(x, P_x) = h(x): a point that comes into contact has lost its gap."""
    x = np.array([1.2, 2.0, 7.0])
    # Over (E*/R)
    gap = 2 / np.pi * contact.slip_integral(x, 1e6) / _bend(contact)
    np.testing.assert_allclose(gap, (x - contact.least) ** 2 / 2, rtol=3e-15)


@pytest.mark.parametrize("load", [1e-9, 1e-3, 0.3, 1.0, 50.0, 1e9])
@CONTACTS
def test_slip_area_is_right_from_the_smallest_front_to_the_whole_contact(contact, load):
    """Lam(P, P_c) from P - P_c = 1e-14 P upwards, against 60 digits."""
    with mp.workdps(60):
        for part in (1e-14, 1e-7, 1e-3, 0.29, 0.31, 0.7, 0.999):
            drop = load * part
            exact = float(area_in_many_digits(contact, mp.mpf(load), mp.mpf(load) - mp.mpf(drop)))
            assert float(contact.dissipation_kernel(load, drop)) == pytest.approx(exact, rel=1e-13), part


def area_in_many_digits(contact, load, front):
    if contact is HERTZ:
        return (load * mp.log(load / front) - load + front) / 2

    def primitive(tau):
        return ((1 + tau**2) * mp.atan(tau) - tau) / 2 - tau + mp.atan(tau)

    def tau_of(value):
        tau = mp.mpf(float(inverse_load_function(float(value))))
        for _ in range(8):
            tau -= ((1 + tau**2) * mp.atan(tau) - tau - value) / (2 * tau * mp.atan(tau))
        return tau

    one, two = tau_of(load), tau_of(front)
    return load * mp.log((1 + one**2) / (1 + two**2)) / 2 - primitive(one) + primitive(two)


def test_log_excess_keeps_relative_accuracy():
    for ratio in (1e-18, 1e-12, 1e-5, 0.1, 0.3, 0.3001, 0.9, 1 - 1e-12):
        with mp.workdps(60):
            exact = float(-mp.log(1 - mp.mpf(ratio)) - mp.mpf(ratio))
        assert float(log_excess(ratio)) == pytest.approx(exact, rel=1e-15)


def test_a_vanishing_flat_is_hertz():
    nearly = PunchSuperposition(flat_and_rounded(modulus=3.0, radius=2.0, flat_half_length=1e-8), datum_length=5.0)
    x, load = np.array([0.0, 0.4, 0.9, 3.0]), 1.7
    np.testing.assert_allclose(nearly.pressure(x, load), HERTZ.pressure(x, load), rtol=0, atol=1e-7)
    np.testing.assert_allclose(nearly.slip_integral(x, load), HERTZ.slip_integral(x, load), rtol=0, atol=1e-7)
    assert float(nearly.dissipation_kernel(load, 0.4)) == pytest.approx(float(HERTZ.dissipation_kernel(load, 0.4)), rel=1e-7)


def test_unlike_bodies_have_a_modulus_and_a_coupling_constant():
    soft = Elastic(young_modulus=1.0, poisson_ratio=0.25)
    pair = Materials(upper=soft, lower=UNIT)
    assert composite_modulus(pair) == pytest.approx(1 / (0.9375 + 0.5))
    assert coupling_constant(pair) == -coupling_constant(Materials(upper=UNIT, lower=soft)) != 0
    assert coupling_constant(Materials(upper=soft, lower=soft)) == 0


def test_an_unknown_profile_is_refused_by_name():
    scene = make_scene(polygon([(1.0, 0.0)]))

    class Wedge:
        kind = "wedge"

    with pytest.raises(InputError, match=r"profile\.kind = 'wedge'"):
        contact_of(Wedge(), scene.material)
