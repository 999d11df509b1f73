"""Friction work: 30-digit references, closed forms, and what must and must not change it."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import load_scene
from semi_analytic import solve
from semi_analytic.elasticity import composite_modulus
from semi_analytic.friction_work import CONVERGED, by_halving
from semi_analytic.quadrature import crowded
from semi_analytic_cases import REFERENCE, ellipse, make_scene, polygon, reference_scene

ONLY = ("dissipation",)


@pytest.mark.parametrize(
    "row", REFERENCE, ids=lambda row: f"b{row['flat']}-{row['phase']:.0f}-f{row['friction']:g}-{row['tangential']:.2g}"
)
def test_global_dissipation_is_that_of_thirty_digits(row):
    """Worst measured 7e-13 relative."""
    assert solve(reference_scene(row), x=[0.0], fields=ONLY).dissipation == pytest.approx(
        float(row["dissipation"]), rel=1e-12, abs=0
    )


@pytest.mark.parametrize(
    "row", REFERENCE, ids=lambda row: f"b{row['flat']}-{row['phase']:.0f}-f{row['friction']:g}-{row['tangential']:.2g}"
)
def test_pointwise_dissipation_is_that_of_thirty_digits(row):
    """Worst measured 1e-12 of max W."""
    density = solve(reference_scene(row), x=row["x"], fields=("dissipation_density",)).dissipation_density
    exact = [float(value) for value in row["density"]]
    np.testing.assert_allclose(density, exact, rtol=0, atol=1e-11 * max(exact))


def test_reference_table_covers_both_geometries_and_its_own_claims():
    assert len(REFERENCE) == 41
    assert {row["flat"] for row in REFERENCE} == {0.0, 0.7}
    assert {row["friction"] for row in REFERENCE} == {1e-3, 0.3, 1.0, 10.0}


def test_paper_scene_against_thirty_digits():
    """W/(A f^2 P0^2) does not know E, R or the size of the loads: the paper's P0 = 3 in units serves for the library's scene."""
    paper = next(row for row in REFERENCE if row["mean"] == 3.0)
    scene = load_scene("hertz-paper")
    scale = 2 / composite_modulus(scene.material) * scene.load.mean_normal_load**2
    assert solve(scene, fields=ONLY).dissipation / scale == pytest.approx(float(paper["dissipation"]) / 2 / 9, rel=1e-12, abs=0)


@pytest.mark.parametrize("use", [1e-9, 1e-4, 0.3, 0.6, 0.99, 1 - 1e-9])
def test_constant_normal_load_has_its_closed_form(use):
    """W = (4 f^2 P^2/(pi E*)) [(1 - k) ln(1 - k) + k - k^2/2], k = Q/(f P); where that loses all digits, k^3/6 (1 + k/2 + ...)."""
    friction, load = 0.5, 90.0
    q = use * friction * load
    scene = make_scene(polygon([(load, 0.0)], [(load, q), (load, -q)]), friction, modulus=7.0)
    bracket = (1 - use) * math.log1p(-use) + use - use**2 / 2 if use > 1e-3 else use**3 / 6 * (1 + use / 2 + 0.3 * use**2)
    solution = solve(scene, fields=ONLY)
    assert solution.dissipation == pytest.approx(
        4 * friction**2 * load**2 / (math.pi * 7.0) * bracket, rel=1e-10 if use < 1e-3 else 1e-12, abs=0
    )
    assert solution.steady_from == 1


def test_constant_normal_load_as_an_ellipse_is_the_same():
    one = solve(make_scene(ellipse(3.0, 0.0, 0.0, 1.2), 0.5), fields=ONLY)
    two = solve(make_scene(polygon([(3.0, 0.0)], [(3.0, 1.2), (3.0, -1.2)]), 0.5), fields=ONLY)
    assert one.dissipation == pytest.approx(two.dissipation, rel=1e-13, abs=0)


@pytest.mark.parametrize("phase", [3.58764470035453e-08, 1.3831076412129431e-09, 2.508829044986121e-09, -1e-7, 180 - 1e-7, 1e-6])
@pytest.mark.parametrize("load", [1.0, 10.0, 183.45937329584282])
def test_what_sticks_for_ever_on_loads_next_to_a_line(phase, load):
    """P_T = P0 - (u + v)/2.

    P turns an instant before slip does, and the front stands on a knot: only rounding would take it beyond.
    """
    for ratio, use, friction in ((0.06, 0.25, 1.0), (0.12965094225905563, 0.6364538540831083, 1.0), (0.25, 0.63, 0.3)):
        q1 = use * friction * (1 - ratio)
        found = solve(
            make_scene(ellipse(load, ratio * load, 0.0, q1 * load, phase), friction, 0.0, 1 / load, 1.0), x=[0.0], fields=ONLY
        )
        r = q1 / friction * cmath.exp(-1j * math.radians(phase))
        permanent = 1 - (abs(r - ratio) + abs(r + ratio)) / 2
        assert found.permanent_stick_half_width == pytest.approx(math.sqrt(4 * permanent / math.pi), rel=1e-9)


CYCLES = {
    "ratio": st.floats(0.0, 0.97),
    "use": st.floats(0.05, 0.97),
    "phase": st.floats(-179, 179),
    "friction": st.floats(0.01, 5),
    "flat": st.sampled_from([0.0, 0.1, 2.0]),
}


@settings(max_examples=25)
@given(**CYCLES, loads=st.floats(-12, 12), lengths=st.floats(-9, 9), moduli=st.floats(-12, 12))
def test_answer_is_free_of_units(ratio, use, phase, friction, flat, loads, lengths, moduli):
    """Loads, lengths and E scaled at will: W/(A f^2 P0^2) and c/a agree. The profile goes along with the loads."""
    load, length, modulus = 10.0**loads, 10.0**lengths, 10.0**moduli
    q1 = use * friction * (1 - ratio)
    one = solve(make_scene(ellipse(1.0, ratio, 0.0, q1, phase), friction, flat), x=[0.0], fields=ONLY)
    other = make_scene(
        ellipse(load, ratio * load, 0.0, q1 * load, phase), friction, flat * length, modulus * length**2 / load, modulus
    )
    two = solve(other, x=[0.0], fields=ONLY)
    assert two.dissipation * modulus / load**2 == pytest.approx(one.dissipation, rel=1e-11, abs=1e-15 * friction**2)
    assert two.permanent_stick_half_width / length == pytest.approx(one.permanent_stick_half_width, rel=1e-10)


@settings(max_examples=25)
@given(**CYCLES, mean=st.floats(-0.9, 0.9))
def test_mean_shear_mirror_and_sense_of_turning(ratio, use, phase, friction, flat, mean):
    """Q0 plays no part; Q -> -Q neither; nor which way round the loop, as far as the mirrored loop is the other sense."""
    q1 = use * friction * (1 - ratio)
    q0 = mean * friction * (1 - ratio) * (1 - use)
    works = [
        solve(make_scene(ellipse(1.0, ratio, mean_load, q1, angle), friction, flat), x=[0.0], fields=ONLY).dissipation
        for mean_load, angle in ((0.0, phase), (q0, phase), (-q0, phase - math.copysign(180, phase)))
    ]
    np.testing.assert_allclose(works, works[0], rtol=1e-10, atol=1e-15 * friction**2)


def test_full_stick_dissipates_nothing_and_integrates_nothing():
    solution = solve(load_scene("full-stick"))
    assert solution.dissipation == 0
    assert np.all(solution.dissipation_density == 0)
    assert solution.work.counts["slip_quadratures"] == 0
    assert solution.work.skipped["quadratures"][1] == "full stick: nothing slips"
    assert solution.steady_from == 0


def test_no_friction_dissipates_nothing():
    scene = make_scene(ellipse(3.0, 1.0, 0.0, 0.0), friction=0.0)
    solution = solve(scene)
    assert solution.dissipation == 0
    assert np.all(solution.shear == 0)


def test_transient_work_is_counted_by_cycle_and_later_cycles_are_copies():
    scene = load_scene("hertz-paper")
    start = scene.load.path().cycle_start
    own = solve(scene, fields=ONLY)
    long = solve(scene, x=[0.0], time=start + 2 * np.pi * np.array([0.5, 1.0, 40.25]), fields=ONLY)
    assert own.cycle_dissipation.shape == (2,)
    assert own.cycle_dissipation[0] > 2 * own.cycle_dissipation[1]
    np.testing.assert_array_equal(long.cycle_dissipation, [own.cycle_dissipation[0], *[own.dissipation] * 39])
    assert long.work.counts["cycles_solved"] == 2
    assert long.work.skipped["cycles"][0] == 38
    first = solve(scene, x=[0.0], time=[start + 7.0], fields=ONLY)
    assert first.dissipation == own.cycle_dissipation[0]


def test_second_route_is_on_record_where_it_exists():
    solution = solve(load_scene("hertz-paper"), fields=ONLY)
    assert solution.loop_work == pytest.approx(solution.dissipation, rel=1e-12, abs=0)
    start = load_scene("hertz-paper").load.path().cycle_start
    for turns in (1.0, 1.5):  # the second knows of the steady cycle, but answers for the first
        transient = solve(load_scene("hertz-paper"), x=[0.0], time=[start + turns * 2 * math.pi], fields=ONLY)
        assert math.isnan(transient.loop_work)
        assert "not steady" in transient.record.notes[0]


def test_halving_ends_between_neighbouring_numbers():
    """A range of 450 last digits: halved to one of these it stayed as long as it was, and was halved for ever."""
    rounds = []

    def rough(which, low, high):
        rounds.append(len(which))
        assert len(rounds) < 40, "a loop without end"
        return np.ones(len(which))

    found = by_halving(rough, [1.0], [1.0 + 1e-13], CONVERGED)
    assert len(rounds) == 19
    assert found.error[0] > 0


def test_what_is_not_finite_is_not_halved():
    rounds = []

    def lost(which, low, high):
        rounds.append(len(which))
        return np.full(len(which), np.nan)

    assert np.isnan(by_halving(lost, [0.0], [1.0], CONVERGED).value[0])
    assert rounds == [1, 2]


def test_a_corner_next_to_an_end_does_not_pass_for_halving():
    """A part cut off by the last digit changes nothing: W(x) at a knot of a table was 4e-9 off, stated 2e-13."""

    def rough(_, low, high):
        nodes, weights = crowded(low, high)
        return np.sum(weights * np.sqrt(np.abs(nodes - 0.3)), axis=-1)

    found = by_halving(rough, [0.0], [1.0], CONVERGED, [1 - 1e-15])
    assert found.value[0] == pytest.approx((0.3**1.5 + 0.7**1.5) / 1.5, rel=1e-8)
    cut = by_halving(rough, [0.0], [1.0], CONVERGED, [0.3, 1 - 1e-15])
    assert cut.value[0] == pytest.approx((0.3**1.5 + 0.7**1.5) / 1.5, rel=1e-13)
