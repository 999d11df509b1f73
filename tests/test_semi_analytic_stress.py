"""Where the half-plane engine is under stress: next to no slip, loads of 1e24, tangency; a right figure with an honest error."""

import math

import mpmath
import numpy as np
import pytest

from scenes import Compound, EvenPolynomial, HarmonicLoad, PowerLaw, TimeSeriesLoad, Wedge
from semi_analytic import solve
from semi_analytic.profiles import contact_of
from semi_analytic_cases import ellipse, make_scene, polygon


def mindlin(share, friction, load):
    """W of a cycle of Q between +-share f P at constant P, E* = 1, by sixty digits."""
    with mpmath.workdps(60):
        k = mpmath.mpf(share)
        return 4 * (mpmath.mpf(friction) * load) ** 2 / mpmath.pi * ((1 - k) * mpmath.log(1 - k) + k - k * k / 2)


def to_and_fro(share, friction, load):
    """The scene of that cycle."""
    force = share * friction * load
    return make_scene(polygon([(load, 0.0)], [(load, force), (load, -force)]), friction)


@pytest.mark.parametrize("share", [10.0**-k for k in range(4, 15)])
@pytest.mark.parametrize(("friction", "load"), [(0.3, 1.0), (1.0, 0.7)])
def test_the_less_slips_the_more_doubt_is_told(share, friction, load):
    """P_c is known to a digit of P, W goes with (P - P_c)^3: at 1e-13 of f P that is 3 %. Before, the first cycle counted as steady
    below 1e-12 of f P: 19 % less, and not a word of it.
    """
    answer = solve(to_and_fro(share, friction, load), x=[0.0], fields=("dissipation",))
    exact = share * friction * load / (mpmath.mpf(friction) * load)
    error = abs(float(answer.dissipation / mindlin(exact, friction, load) - 1))
    told = answer.record.errors["dissipation"]
    assert error <= told <= 5e-15 / share
    if math.isfinite(answer.loop_work):
        apart = float(abs(answer.loop_work / mindlin(exact, friction, load) - 1))
        assert 1e-9 < apart <= answer.record.errors["loop_work"] < 2e-2
        assert any(note.startswith("loop_work: ") and note.endswith(" of it") for note in answer.record.notes)


def test_the_second_route_tells_its_error_along_an_ellipse_too():
    """P varies by a thousandth and next to nothing slips: W keeps more digits than the other route, and both say so."""
    answer = solve(make_scene(ellipse(1.0, 1e-3, 0.0, 5e-8), 0.5, flat=0.7), x=[0.0], fields=("dissipation",))
    apart = abs(answer.loop_work / answer.dissipation - 1)
    assert 1e-7 < apart <= answer.record.errors["loop_work"] < 1e-5
    assert "loop_work" not in solve(make_scene(ellipse(), 1.0), x=[0.0], fields=("dissipation",)).record.errors


@pytest.mark.parametrize("share", [1e-3, 1e-9, 1e-12])
def test_long_series_tell_it_too(share):
    """2,401 rows: a line of the memory keeps its own length. By knots alone 5 % of W was missing at 1e-12 of f P, 9e-6 at 1e-9."""
    turn = np.arange(2401) / 2400
    force = share * 0.5 * np.sin(2 * np.pi * turn)
    force[-1] = force[0]
    rows = np.column_stack([turn, np.ones_like(turn), force])
    answer = solve(make_scene(TimeSeriesLoad(rows=rows, repeats=True), 0.5), x=[0.0], fields=("dissipation",))
    error = abs(float(answer.dissipation / mindlin(np.max(force) / 0.5, 0.5, 1.0) - 1))
    assert answer.steady_from == 1
    assert error < 1e-13
    assert error <= answer.record.errors.get("dissipation", 3e-12) <= 3e-15 / share


def test_where_much_slips_nothing_is_told_and_both_routes_agree():
    answer = solve(to_and_fro(0.6, 0.3, 1.0), x=[0.0], fields=("dissipation",))
    assert "dissipation" not in answer.record.errors
    assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-12)


@pytest.mark.parametrize(
    "profile_of",
    [
        lambda length: Compound(inner_radius=length, outer_radius=0.4 * length, inner_half_length=0.8 * length),
        lambda length: Wedge(tip_radius=length, tip_half_length=0.7 * length),
        lambda length: EvenPolynomial(length=length, rises=(0.5 * length, 0.1 * length)),
    ],
    ids=["compound", "wedge", "polynomial"],
)
@pytest.mark.parametrize(("longer", "stiffer"), [(1e12, 1e12), (1e-12, 1e-12)])
def test_loads_of_any_size(profile_of, longer, stiffer):
    """P of 1e24 overflowed in the quotient of a traction next to its own edge: a warning, and with it a crash under -W error."""
    x, amounts = np.linspace(-2.5, 2.5, 21), np.array([3.0, 1.0, 0.2, 0.8])
    answers = []
    for length, stress in ((1.0, 1.0), (longer, stiffer)):
        scene = make_scene(ellipse(*(amounts * length * stress), 70.0), 0.5, modulus=stress)
        scene = scene.vary(profile=profile_of(length))
        answers.append(solve(scene, x=x * length))
    one, other = answers
    units = {
        "pressure": stiffer,
        "shear": stiffer,
        "slip": longer,
        "tangential_displacement": longer,
        "dissipation_density": longer * stiffer,
    }
    for name, unit in units.items():
        here = getattr(one, name)
        np.testing.assert_allclose(getattr(other, name) / unit, here, rtol=0, atol=1e-12 * np.max(np.abs(here)), err_msg=name)
    np.testing.assert_array_equal(one.state, other.state)
    assert other.dissipation / (longer**2 * stiffer) == pytest.approx(one.dissipation, rel=1e-12)


@pytest.mark.parametrize("friction", [1e-6, 1 / 3, 1.0, 100.0])
@pytest.mark.parametrize("beyond", [-1e-12, -1e-15, 0.0, 2e-16, 1e-15, 1e-12])
def test_a_line_at_the_slope_of_friction_sticks_or_slips_by_no_more_than_rounding(friction, beyond):
    """dQ/dP = f (1 + e): nothing slips for e <= 0, and W is of the order e f^2 P^2 above."""
    loads = ellipse(2.0, 1.0, 0.1 * friction, friction * (1 + beyond), 0.0)
    work = solve(make_scene(loads, friction), x=[0.0], fields=("dissipation",)).dissipation / friction**2
    assert 0 <= work <= max(beyond, 2e-16 if beyond else 0.0)


@pytest.mark.parametrize("part", [0.9, 0.999, 1 - 1e-6, 1 - 1e-9])
def test_a_face_that_is_nearly_all_flat_keeps_both_routes_to_the_work(part):
    """The half-width varies by 1 - b/a, and so does the logarithm in U: lost under ln(2 L/b), Q dU was off by 5e-6 at 1e-9."""
    flat = make_scene(ellipse(), 0.5, flat=part)
    load = float(contact_of(flat.profile, flat.material).load(1.0))
    answer = solve(make_scene(ellipse(0.75 * load, 0.25 * load, 0.0, 0.2 * load, 70.0), 0.5, flat=part), x=[0.0])
    assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-12, abs=0)  # 1.3e-13, at b/a = 0.9


def test_the_work_of_a_load_that_all_but_leaves():
    """P_min/P0 = 1e-12: sixty digits by integrals over ever shorter parts, given here to twenty."""
    left = 1e-12
    scene = make_scene(ellipse(1.0, 1 - left, 0.0, 0.2 * left, 90.0), 0.5, radius=100.0)
    assert solve(scene, x=[0.0]).dissipation == pytest.approx(5.0929581788030931689e-26, rel=1e-14, abs=0)  # 3e-16


@pytest.mark.parametrize("swing", [1e-17, 1e-280, 2.2e-311, 5e-324])
def test_a_load_that_swings_by_less_than_any_number_holds_still(swing):
    """Amplitudes without an inverse were a warning of overflow, out of roots that they are divided by."""
    load = {"kind": "harmonics", "mean_normal_load": 1.0, "mean_tangential_load": 0.0, "tangential_harmonics": [[0.2, 30.0]]}
    scene = make_scene(HarmonicLoad(**load, normal_harmonics=[(swing, 20.0)]), 0.5)
    assert solve(scene, x=[0.0]).dissipation == pytest.approx(float(mindlin(0.4, 0.5, 1.0)), rel=1e-13, abs=0)


def wedge_scene(load):
    """A sharp wedge of unit slope: P = a with E* = 1."""
    return make_scene(load, 0.5).vary(profile=PowerLaw(exponent=1.0, length=1.0, rise=1.0))


def test_the_shear_at_the_very_tip_of_a_wedge_is_a_sum_of_logarithms():
    """Q to 0.3 f P at constant P: q = f [p(P) - p(P_c)], p(x, P) = arccosh(P/x)/pi, both infinite at x = 0: inf - inf before."""
    load = polygon([(1.0, 0.0), (1.0, 0.3)])
    with mpmath.workdps(60):
        tiny = mpmath.mpf(10) ** -25
        brute = (mpmath.acosh(1 / tiny) - mpmath.acosh(mpmath.mpf("0.4") / tiny)) / (2 * mpmath.pi)
    answer = solve(wedge_scene(load), x=[0.0], time=[2.0])
    assert answer.shear.item() == pytest.approx(float(brute), rel=1e-14)  # f ln(2.5)/pi
    assert np.isinf(answer.pressure.item())
    assert answer.record.certificates["cone"].item() == 0


@pytest.mark.parametrize(
    ("load", "sign"),
    [
        (polygon([(1.0, 0.0), (1.5, 0.3)], [(0.7, -0.1), (1.4, 0.3)]), 0.0),
        (polygon([(1.0, 0.0), (1.0, 0.3)], [(1.0, -0.3), (0.8, 0.2)]), 0.0),
        (polygon([(1.0, 0.1), (1.5, 0.3)], [(0.7, -0.1), (1.4, 0.3)]), 1.0),
        (ellipse(1.0, 0.4, 0.0, 0.1, 70.0), -1.0),
    ],
    ids=["sticks", "slips", "sheared from the start", "ellipse"],
)
def test_the_shear_next_to_the_tip_of_a_wedge_tends_to_that_at_the_tip(load, sign):
    """To a finite one if no shear was there with the first load; else it grows with the pressure, in its sign."""
    scene = wedge_scene(load)
    tip, near, nearer = solve(scene, x=[0.0, 1e-9, 1e-10], fields=("shear",)).shear[1:].T
    if sign:
        np.testing.assert_array_equal(tip, sign * np.inf)
        assert np.all(sign * nearer > sign * near)
    else:
        np.testing.assert_allclose(tip, nearer, rtol=0, atol=1e-14)
        assert np.ptp(tip) > 0.01
