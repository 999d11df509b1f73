"""Tabulated profiles: exact for the spline that they are, Hertz for rows of a parabola, in the limit right for any curve."""

import mpmath as mp
import numpy as np
import pytest

from scenes import FlatRounded, Hertz, InputError, Tabulated
from semi_analytic import pile, solve
from semi_analytic.hertz import HertzContact
from semi_analytic.panels import panels
from semi_analytic_cases import ellipse, make_scene, polygon
from semi_analytic_truth import Truth, profile_contact, worst


def table(height, extent, count, sides=1):
    x = np.linspace(-extent if sides == 2 else 0.0, extent, sides * (count - 1) + 1)
    return Tabulated(points=np.stack([x, height(x)], axis=1))


def test_kernels_of_the_spline_against_quadrature():
    """Measured: 4e-16, the slip area 3e-13."""
    contact = profile_contact(table(lambda x: np.cosh(x) - 1, 1.0, 5))
    knots, bends = ([mp.mpf(float(v)) for v in values] for values in (contact.knots, contact.curvature))
    pieces = list(zip(bends, knots[:-1], knots[1:], strict=True))

    def rate(a):
        return a * sum(k * (mp.asin(min(end / a, 1)) - mp.asin(begin / a)) for k, begin, end in pieces if begin < a)

    truth = Truth(1, lambda x: sum(k * (min(max(x, a), b) - a) for k, a, b in pieces), rate, tuple(contact.knots[1:-1]))
    found = worst(contact, truth, (1e-6, 0.4, 0.9), relative_x=(0.0, 0.9, 1.05))
    for name, error in found.items():
        assert error < {"log_area": 1e-11, "pressure": 1e-12, "pressure_moment": 1e-12}.get(name, 1e-13), name


def test_moments_of_many_rows():
    """P p - int p dP by Gauss' rule between the knots, p being a sum of tips: measured 3e-9, the roots being its limit."""
    contact = profile_contact(table(lambda x: np.cosh(x) - 1, 1.0, 41))
    half, x = 0.9, np.array([0.1, 0.5, 0.85, 0.95])
    load = float(contact.load(half))
    node, weight = np.polynomial.legendre.leggauss(40)
    for at in x:
        marks = np.unique(np.concatenate([[min(at, half), half], contact.knots[(contact.knots > at) & (contact.knots < half)]]))
        # a = mark + step^2: behind each knot everything is smooth in the root.
        step = np.sqrt(np.diff(marks))[:, None]
        inner = marks[:-1, None] + np.square(step * (1 + node) / 2)
        inside = np.sum(step**2 * (1 + node) / 2 * weight * contact.pressure(at, contact.load(inner)) * contact.stiffness(inner))
        exact = load * float(contact.pressure(at, load)) - inside
        assert float(contact.pressure_moment(at, load)) == pytest.approx(exact, rel=1e-8, abs=1e-15)


@pytest.mark.parametrize("sides", [1, 2])
def test_rows_of_a_parabola_are_hertz(sides):
    contact = profile_contact(table(lambda x: x * x / 4, 3.0, 41, sides))
    hertz = HertzContact(modulus=1.0, radius=2.0, datum_length=3.0)
    x, load = np.array([0.0, 0.2, 0.9, 2.5]), 0.8
    for name in ("pressure", "spread"):
        np.testing.assert_allclose(getattr(contact, name)(x, load), getattr(hertz, name)(x, load), rtol=1e-12, atol=1e-15)
    for name in ("half_width", "log_distance"):
        assert float(getattr(contact, name)(load)) == pytest.approx(float(getattr(hertz, name)(load)), rel=1e-13)
    for slipped in (1e-6, 0.01, 0.3):
        assert float(contact.log_area(load, slipped)) == pytest.approx(float(hertz.log_area(load, slipped)), rel=1e-9)


def test_more_rows_come_closer_with_the_square_of_the_step():
    """1 - sqrt(1 - x^2) against a fine table of itself: four times the rows, a sixteenth of the error at least."""
    half = np.linspace(0.3, 0.75, 40)
    fine = profile_contact(table(lambda x: 1 - np.sqrt(1 - x * x), 0.8, 641)).load(half)
    errors = []
    for count in (11, 41, 161):
        contact = profile_contact(table(lambda x: 1 - np.sqrt(1 - x * x), 0.8, count))
        errors.append(np.max(np.abs(contact.load(half) / fine - 1)))
    assert errors[0] / errors[1] > 12
    assert errors[1] / errors[2] > 12
    assert errors[2] < 1e-5


def test_rows_of_a_flat_and_rounded_face_tend_to_it():
    profile = FlatRounded(radius=1.0, flat_half_length=0.5)
    flat = profile_contact(profile)
    contact = profile_contact(table(profile.height, 2.0, 401))
    load = np.array([1e-2, 0.1, 0.5])
    np.testing.assert_allclose(contact.half_width(load), flat.half_width(load), rtol=2e-4)
    assert float(contact.half_width(0.0)) == pytest.approx(0.5, abs=0.006)


def test_half_width_inverts_load_over_sixteen_decades():
    contact = profile_contact(table(lambda x: np.cosh(x) - 1, 3.0, 61))
    load = float(contact.load(2.99)) * 10.0 ** np.linspace(-16, 0, 161)
    np.testing.assert_allclose(contact.load(contact.half_width(load)), load, rtol=2e-14)


def test_height_goes_through_the_rows_and_is_the_initial_gap():
    rows = [[0.0, 0.0], [0.3, 0.01], [0.5, 0.08], [1.1, 0.2], [1.5, 1.0]]
    profile = Tabulated(points=rows)
    np.testing.assert_allclose(profile.height([row[0] for row in rows]), [row[1] for row in rows], atol=1e-16)
    fine = profile.height(np.linspace(-2, 2, 4001))
    assert np.all(np.diff(fine[2000:]) >= 0)
    np.testing.assert_array_equal(profile.height(-np.linspace(-2, 2, 4001)), fine)
    smooth = table(lambda x: np.cosh(x) - 1, 2.0, 21)
    x = np.array([0.33, 1.0, 1.9])
    contact = profile_contact(smooth)
    np.testing.assert_allclose(2 / np.pi * contact.spread(x, float(contact.load(1.99))), smooth.height(x), rtol=1e-13)
    np.testing.assert_allclose(smooth.height(x), np.cosh(x) - 1, rtol=1e-3)
    np.testing.assert_allclose(
        Tabulated(points=[[0, 0], [1, 0.5], [2, 2.0]]).height([0.7, 1.5]), Hertz(radius=1.0).height([0.7, 1.5])
    )


def test_a_contact_wider_than_the_table_is_refused():
    contact = profile_contact(table(lambda x: x * x / 2, 1.0, 11))
    with pytest.raises(InputError, match=r"normal load 2 needs a contact wider than the table, whose last x = 1 carries 0\.785"):
        contact.half_width(2.0)


def test_rows_under_which_the_contact_splits_are_refused():
    rows = [[0, 0], [0.2, 0.2], [0.4, 0.4], [0.6, 0.4], [0.8, 0.4], [1.0, 0.41]]
    with pytest.raises(InputError, match=r"split near a half-width of"):
        profile_contact(Tabulated(points=rows))


def test_dissipation_of_a_table_by_two_routes():
    """Quadrature over time and along arcs is cut where an edge passes a knot: 4e-6 apart where it was not, measured 1e-14."""
    profile = table(lambda x: np.cosh(x) - 1, 3.0, 31)
    scene = make_scene(ellipse()).vary(profile=profile)
    solution = solve(scene, x=[0.0], fields=("dissipation",))
    assert solution.loop_work == pytest.approx(solution.dissipation, rel=1e-11, abs=0)


@pytest.mark.parametrize("load", [1e-12, 1e-6, 1e-2])
def test_beside_a_flat_small_loads_keep_their_digits(load):
    """Rows with a flat middle: the exact P(a) of a rounded flat up to the second knot."""
    profile = Tabulated(points=[[0, 0], [0.5, 0], [0.75, 0.03], [1, 0.12], [1.5, 0.5]])
    contact = profile_contact(profile)
    bend = float(contact.curvature[np.flatnonzero(contact.curvature)[0]])
    flat = profile_contact(FlatRounded(radius=1 / bend, flat_half_length=contact.least))
    small = load * float(contact.load(contact.breaks[0]))
    x = np.array([0.0, 0.4, 0.499])
    np.testing.assert_allclose(contact.half_width(small) - contact.least, flat.half_width(small) - contact.least, atol=4e-16)
    # What the last digit of a is worth over a - b: all that half-widths can tell.
    digits = 1e-11 + 4e-16 / (float(flat.half_width(small)) - contact.least)
    np.testing.assert_allclose(contact.pressure(x, small), flat.pressure(x, small), rtol=digits)
    assert float(contact.log_area(small, 0.3 * small)) == pytest.approx(float(flat.log_area(small, 0.3 * small)), rel=10 * digits)


def test_work_across_knots_is_cut_at_those_between_alone(monkeypatch):
    """Cut at every knot that any instant crosses, 60 knots took twenty times the nodes for the same W."""
    cuts = []

    def seen(begin, end, breaks):
        cuts.extend(np.all((begin <= at) & (at <= end)) for at in breaks)
        return panels(begin, end, breaks)

    monkeypatch.setattr(pile, "panels", seen)
    load = polygon([(1.0, 0.0)], [(0.4, 0.1), (0.8, -0.15), (1.0, 0.1)])
    solve(make_scene(load, 0.7).vary(profile=table(lambda x: np.cosh(x) - 1, 1.2, 61)), x=[0.0])
    assert len(cuts) > 9
    assert all(cuts)
