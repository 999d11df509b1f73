"""Histories: harmonics, Python functions, time series, degenerate ellipses; steady states, shakedown, initial loadings."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import (
    NORMAL_LOAD,
    CallableLoad,
    ChebyshevSegment,
    Combination,
    Compound,
    HarmonicLoad,
    HarmonicSegment,
    InadmissibleLoadError,
    InputError,
    Tabulated,
    TimeSeriesLoad,
    Wedge,
    ellipse_segment,
    load_scene,
)
from semi_analytic import FIELDS, load_series, solution, solve
from semi_analytic.load_series import follow, knots_of
from semi_analytic_cases import ellipse, make_scene, polygon

X = np.linspace(0, 2.3, 12)


def by_spans(scene, **options):
    """The answer by the engine of curved paths."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solution, "own_series", lambda scene, time: None)
        return solve(scene, **options)


THREE = HarmonicLoad(
    mean_normal_load=3,
    mean_tangential_load=0.3,
    normal_harmonics=[(0.8, 0), (0.3, 40), (0.2, -70)],
    tangential_harmonics=[(0.7, 90), (0.4, 10), (0.1, 100)],
)


def series_of(path, count):
    """A cycle as rows on the path, closed to the last digit."""
    time = np.linspace(path.cycle_start, path.cycle_start + path.period, count)
    rows = np.stack([time, *path.at(time)], axis=1)
    rows[-1, 1:] = rows[0, 1:]
    return TimeSeriesLoad(rows=rows, repeats=True)


def as_functions(load):
    path = load.path()
    return CallableLoad(
        normal_load=lambda t: path.at(path.cycle_start + t)[0],
        tangential_load=lambda t: path.at(path.cycle_start + t)[1],
        duration=path.period,
        repeats=True,
    )


@pytest.mark.parametrize("phase", [90.0, -90.0, 35.0, -150.0])
def test_one_harmonic_and_functions_are_the_ellipse(phase):
    known = ellipse(3.0, 1.0, 0.4, 0.9, phase)
    one = HarmonicLoad(
        mean_normal_load=3.0, mean_tangential_load=0.4, normal_harmonics=[(1.0, 0.0)], tangential_harmonics=[(0.9, phase)]
    )
    exact = solve(make_scene(known), x=X)
    for load in (one, as_functions(known)):
        other = solve(make_scene(load), x=X)
        assert other.dissipation == pytest.approx(exact.dissipation, rel=1e-12, abs=0)
        assert other.loop_work == pytest.approx(exact.dissipation, rel=1e-12, abs=0)
        np.testing.assert_allclose(other.dissipation_density, exact.dissipation_density, atol=1e-12 * exact.dissipation)
        assert other.steady_from == 1
        assert other.permanent_stick_half_width == pytest.approx(exact.permanent_stick_half_width, rel=1e-12)


def test_senses_mirror_each_other():
    """-Q(t) of phase 60 degrees is Q of phase -120 degrees."""
    one, other = (solve(make_scene(ellipse(3.0, 1.0, 0.3, 0.9, phase)), x=X) for phase in (60.0, -120.0))
    assert one.dissipation == pytest.approx(other.dissipation, rel=1e-13, abs=0)
    np.testing.assert_allclose(one.dissipation_density, other.dissipation_density, rtol=1e-10, atol=1e-14)


@pytest.mark.parametrize("load", [THREE, load_scene("harmonics").load], ids=["three", "library"])
def test_harmonics_by_two_routes_and_by_many_rows(load):
    """W = closed-int Q dU; and 4,000 straight steps, whose error falls with the square of the step."""
    scene = make_scene(load, friction=0.8)
    exact = solve(scene, x=X)
    assert exact.loop_work == pytest.approx(exact.dissipation, rel=1e-11, abs=0)
    assert max(float(np.max(values)) for values in exact.record.certificates.values()) < 1e-13
    coarse, fine = (solve(make_scene(series_of(load.path(), n), friction=0.8)).dissipation for n in (1001, 4001))
    assert abs(coarse / exact.dissipation - 1) > 8 * abs(fine / exact.dissipation - 1)
    assert fine == pytest.approx(exact.dissipation, rel=1e-5, abs=0)


def test_turning_points_are_found_to_rounding():
    """u = Q - f P of an ellipse turns where the arc tangent says; harmonics and series must agree."""
    known = ellipse_segment(0.3, 0.3 + 2 * math.pi, (3.0, 0.2), (1.0, 0.7), 0.9)
    waves = HarmonicSegment(0.3, 0.3 + 2 * math.pi, (3.0, 0.2), ((1.0, 0.0), (1e-300, 0.0)), ((0.7, 0.9),))
    series = as_functions(ellipse(3.0, 1.0, 0.2, 0.7, 50.0)).path().cycle
    for what in ((1.0, 0.0), (-0.6, 1.0), (-0.6, -1.0), (0.0, 1.0)):
        combination = Combination(*what)
        np.testing.assert_allclose(waves.turning_points(combination), known.turning_points(combination), atol=3e-15)
        found = [time for leg in series for time in leg.turning_points(combination)]
        rates = [leg.rates(time) for leg in series for time in leg.turning_points(combination)]
        assert len(found) == 2
        assert all(abs(what[0] * p + what[1] * q) < 1e-13 for p, q in rates)


def test_close_turning_points_are_told_apart():
    """P = t^3/3 - e^2 t turns at -e and e."""
    for e in (0.3, 1e-3):
        leg = ChebyshevSegment(-1.0, 1.0, (0.0, 0.25 - e * e, 0.0, 1 / 12), (0.0,))
        np.testing.assert_allclose(leg.turning_points(NORMAL_LOAD), [-e, e], rtol=1e-9)


def test_a_function_with_corners_is_the_polygon():
    def triangle(t):
        return np.interp(np.mod(t, 4), [0, 1, 3, 4], [0.0, 1.0, -1.0, 0.0])

    load = CallableLoad(normal_load=lambda t: 2.0 + 0 * t, tangential_load=triangle, duration=4.0, repeats=True)
    same = polygon([(2.0, 0.0)], [(2.0, 1.0), (2.0, -1.0)])
    one, other = (solve(make_scene(each, friction=0.8), x=X) for each in (load, same))
    assert one.dissipation == pytest.approx(other.dissipation, rel=1e-12, abs=0)


@pytest.mark.parametrize("phase", [0.0, 180.0])
def test_a_line_dissipates_nothing_or_by_the_closed_form(phase):
    """|dQ/dP| < f on a line: shakedown, no slip in the steady cycle; beyond it, slip both ways."""
    gentle = solve(make_scene(ellipse(3.0, 1.0, 0.0, 0.5, phase), friction=0.8))
    assert abs(gentle.dissipation) < 1e-25
    assert gentle.steady_from is not None
    steep = solve(make_scene(ellipse(3.0, 0.4, 0.0, 0.9, phase), friction=0.8))
    assert steep.dissipation > 0
    assert steep.loop_work == pytest.approx(steep.dissipation, rel=1e-11, abs=0)


def test_constant_q_dissipates_nothing_and_constant_p_what_mindlin_says():
    quiet = solve(make_scene(ellipse(3.0, 1.0, 0.4, 0.0, 90.0), friction=0.8))
    assert quiet.dissipation == 0
    friction, load, share = 0.5, 3.0, 0.4
    scene = make_scene(ellipse(load, 0.0, 0.0, share * friction * load, 90.0), friction=friction)
    solution = solve(scene)
    node, weight = np.polynomial.legendre.leggauss(40)
    z = share * (1 + node) / 2
    exact = -2 * 2 / math.pi * (friction * load) ** 2 * np.sum(weight * share / 2 * (2 * z - share) * np.log(1 - z))
    assert solution.dissipation == pytest.approx(exact, rel=1e-12, abs=0)


@pytest.mark.parametrize("flat", [0.0, 0.5])
@pytest.mark.parametrize("repeats", [False, True])
@given(data=st.data())
@settings(max_examples=15)
def test_rows_as_a_series_are_rows_as_a_curved_path(flat, repeats, data):
    """The lean way and the general one: every field, at rows and between them."""
    size = st.floats(0.05, 1.0)
    corners = data.draw(st.lists(st.tuples(size, st.floats(-0.97, 0.97)), min_size=2, max_size=25, unique=True))
    friction = 0.7
    rows = [[k + 1.0, p, friction * p * use] for k, (p, use) in enumerate(corners)]
    rows += [[len(rows) + 1.0, *rows[0][1:]]] * repeats
    scene = make_scene(TimeSeriesLoad(rows=rows, repeats=repeats), friction=friction, flat=flat)
    # Not at the middle of a step: that may be where nothing slips for an instant, which both may call as they like.
    time = np.arange(1.0, len(rows) + 1.9 * repeats, 0.37)
    lean, full = solve(scene, time=time, x=X[:5]), by_spans(scene, time=time, x=X[:5])
    top = max(p for p, _ in corners)
    scale = {"dissipation": (friction * top) ** 2, "cycle_dissipation": (friction * top) ** 2, "dissipation_density": top}
    for name in ("pressure", "shear", "slip", "tangential_displacement", "normal_approach", *scale):
        one, two = getattr(lean, name), getattr(full, name)
        np.testing.assert_allclose(one, two, rtol=1e-10, atol=1e-11 * scale.get(name, max(top, 1.0)), err_msg=name)
    # c is the root of P_c: a last digit of P counts for 1e-8 there.
    np.testing.assert_allclose(*(np.nan_to_num(each.stick_half_width, nan=flat) for each in (lean, full)), atol=1e-7)
    assert lean.steady_from == full.steady_from
    assert np.max(lean.record.certificates["tangential_balance"]) < 1e-13


@pytest.mark.parametrize("seed", range(30))
def test_rows_along_the_limit_of_friction_and_back_along_their_own_lines(seed):
    """Both ways of following them agree on every state."""
    draw = np.random.default_rng(seed)
    count, flat, repeats = int(draw.integers(2, 14)), float(draw.choice([0.0, 0.5])), bool(seed % 2)
    normal = draw.choice([0.25, 0.5, 0.75, 1.0], count)
    rows = np.column_stack([np.arange(count), normal, 0.7 * normal * draw.choice([-1, -0.5, 0, 0.25, 0.5, 1], count)])
    rows = np.append(rows, [[count, *rows[0, 1:]]], axis=0) if repeats else rows
    scene = make_scene(TimeSeriesLoad(rows=rows, repeats=repeats), 0.7, flat)
    time = np.sort(draw.uniform(0, rows[-1, 0], 9))
    one, other = (way(scene, x=X[:7], time=time) for way in (solve, by_spans))
    assert one.steady_from == other.steady_from
    np.testing.assert_array_equal(one.state, other.state)
    for name in ("slip", "tangential_displacement", "dissipation", "cycle_dissipation", "dissipation_density"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=0, atol=1e-13, err_msg=name)


def test_a_front_at_no_load_is_not_below_it():
    """|Q| = f P is reached and P_c was a last digit below 0: W(x) on a flat face was no number."""
    loads = [(1.0, 0.0), (0.5, 0.0875), (1.0, -0.7), (0.25, 0.04375), (0.75, 0.5249999999999999), (0.5, 0.175), (0.75, 0.0)]
    scene = make_scene(TimeSeriesLoad(rows=[[k, *load] for k, load in enumerate(loads)]), 0.7, 0.5)
    one, other = (way(scene, x=[0.5, 0.8, 1.0], fields=("dissipation_density",)).dissipation_density for way in (solve, by_spans))
    np.testing.assert_allclose(one, other, rtol=1e-12)


@pytest.mark.parametrize(
    "corners", [[(0.92, 1e-12), (0.5, 0.0)], [(0.5, 0.0), (0.512062, 1e-9), (1.0, -1e-12), (0.05, 2e-16), (0.73, -1e-12)]]
)
@pytest.mark.parametrize("flat", [0.0, 0.5])
def test_rows_that_hardly_slip_are_steady_when_the_engine_says_so(corners, flat):
    """However far P goes: what counts is how deep the front of slip went, 1e-12 of P and less."""
    rows = [[k + 1.0, p, 0.7 * p * use] for k, (p, use) in enumerate([*corners, corners[0]])]
    scene = make_scene(TimeSeriesLoad(rows=rows, repeats=True), friction=0.7, flat=flat)
    lean, full = solve(scene, x=X[:5]), by_spans(scene, x=X[:5])
    assert lean.steady_from == full.steady_from == 1
    assert lean.dissipation == pytest.approx(full.dissipation, rel=1e-3, abs=0)


@pytest.mark.parametrize(("share", "steady"), [(0.3, False), (1e-4, True), (1e-9, False), (1e-9, True)])
def test_what_slips_is_that_of_sixty_digits(share, steady):
    """P - P_c at the ends of 120 steps, to four last digits of P, or 1e-14 of itself at constant P; 0.3 of a digit measured."""
    t = 0.37 * np.arange(120)
    normal = 2 + (0 if steady else 0.3) * np.cos(t)
    rows = np.column_stack([normal, 0.1 * normal + 0.35 * share * np.sin(1.7 * t)]).tolist()
    ends = []
    with mp.workdps(60):
        for number in (float, mp.mpf):
            curve, records, slipped, last = None, ([], []), [], (number(0), number(0))
            for p, q in [(2.4, 0.24), *rows]:
                curve = load_series._step(curve, *last, number(p), number(q), number(0.5), records)
                slipped.append(float(records[1][-3]))
                last = (number(p), number(q))
            ends.append(np.array(slipped))
    found, exact = ends
    assert np.max(exact) > 0.3 * share
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-14 * np.max(exact) if steady else 4 * 2.4 * 2.2e-16)


@pytest.mark.parametrize("count", [4, 40, 400])
def test_the_second_route_of_a_series_that_repeats(count):
    """Closed integral of Q dU from P, P_c and Q along the records, W from their slip areas: 1e-13 measured."""
    draw = np.random.default_rng(count)
    normal = draw.uniform(0.3, 2.0, count)
    rows = np.column_stack([np.arange(count), normal, 0.6 * normal * draw.uniform(-0.9, 0.9, count)])
    rows = np.append(rows, [[count, *rows[0, 1:]]], axis=0)
    for flat in (0.0, 0.5):
        answer = solve(make_scene(TimeSeriesLoad(rows=rows, repeats=True), 0.6, flat), x=[0.0], fields=("dissipation",))
        assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-12, abs=0)


def test_a_long_series_answers_what_is_asked_and_nothing_else():
    """Counts of the work: no curve without a field, no quadrature without the dissipation, no field off the instants asked for."""
    t = np.arange(1.0, 1202)
    rows = np.stack([t, 2 + np.cos(0.31 * t), 0.5 * np.sin(0.57 * t)], axis=1)
    scene = make_scene(TimeSeriesLoad(rows=rows))
    bare = solve(scene, fields=())
    assert (bare.work.counts["curves"], bare.work.counts["slip_quadratures"]) == (0, 0)
    assert len(bare.time) == 1202
    assert math.isnan(bare.dissipation)
    assert set(bare.work.skipped) == set(FIELDS)
    work = solve(scene, fields=("dissipation",))
    assert work.work.counts["curves"] == 0
    assert work.work.counts["slip_quadratures"] == work.work.counts["slips"] > 1000
    np.testing.assert_allclose(np.sum(work.record.energy["dissipation"]), work.dissipation, rtol=1e-12)
    assert np.all(work.record.energy["dissipation"] >= 0)
    two = solve(scene, x=X, time=[600.5, 3.0], fields=("shear",))
    assert (two.work.counts["curves"], two.work.counts["slip_quadratures"]) == (2, 0)
    np.testing.assert_allclose(two.shear, by_spans(scene, x=X, time=[600.5, 3.0], fields=("shear",)).shear, atol=1e-13)


def test_a_long_series_with_all_fields_says_what_it_left_out():
    t = np.arange(1.0, 1702)
    rows = np.stack([t, 2 + np.cos(0.31 * t), 0.5 * np.sin(0.57 * t)], axis=1)
    solution = solve(make_scene(TimeSeriesLoad(rows=rows)), x=X[:2], fields=("pressure",))
    assert solution.pressure.shape[0] == len(solution.time) == 427
    assert solution.time[-1] == 1701
    assert any("1275 were left out" in note for note in solution.record.notes)


def test_pieces_alive_stay_few_in_a_random_history():
    """Memory follows the pieces, not the steps: a larger swing erases the smaller ones."""
    rng = np.random.default_rng(3)
    for count in (2_000, 32_000):
        normal = rng.uniform(1.0, 3.0, count)
        rows = np.stack([np.arange(1.0, count + 1), normal, rng.uniform(-0.9, 0.9, count) * normal], axis=1)
        counts = solve(make_scene(TimeSeriesLoad(rows=rows)), fields=()).work.counts
        assert counts["pieces_alive"] < 30
        assert counts["pieces_dropped"] > count / 2


def test_steps_cost_the_same_however_many_went_before():
    """Every knot goes on once and comes off once; what is alive does not grow with the steps."""
    for count in (1000, 4000, 16000):
        t = np.arange(count) * 0.37
        normal, tangential = 2 + np.cos(t) + 0.3 * np.cos(2.7 * t), 0.5 * np.sin(1.3 * t) + 0.2 * np.sin(0.31 * t)
        block = follow(None, np.stack([normal, tangential], axis=1), 1.0)
        assert len(block.records.row) <= 2 * count
        assert block.alive < 40


def test_dying_swings_stay_alive_until_a_larger_one_erases_them():
    swings = np.array([(-1) ** k * 0.6 * (1 - k / 1001) for k in range(1000)])
    rows = np.stack([np.r_[0.0, np.ones(1001)], np.r_[0.0, 0.0, swings]], axis=1)
    curve = follow(None, rows, 1.0).curve
    assert 900 < len(knots_of(curve)[0]) <= 1003
    curve = follow(curve, np.array([rows[-1], [1.0, 0.65]]), 1.0).curve
    assert len(knots_of(curve)[0]) <= 3


def test_a_series_that_repeats_is_followed_until_it_is_steady():
    load = series_of(ellipse(3.0, 1.0, 1.1, 1.0, 90.0).path(), 2001)
    solution = solve(make_scene(load), fields=("dissipation",))
    assert solution.steady_from == 1
    assert solution.record.message == "cycle 2 ends in the state it started from"
    assert solution.cycle_dissipation[0] > solution.cycle_dissipation[1]
    exact = solve(make_scene(ellipse(3.0, 1.0, 1.1, 1.0, 90.0)))
    assert solution.dissipation == pytest.approx(exact.dissipation, rel=1e-5, abs=0)
    assert solution.permanent_stick_half_width == pytest.approx(exact.permanent_stick_half_width, rel=1e-5)


def test_shakedown_of_a_series_is_told():
    """Slip on the initial loading, none ever after."""
    load = TimeSeriesLoad(rows=[[0, 2, 1.0], [1, 3, 1.2], [2, 2, 1.0]], repeats=True)
    solution = solve(make_scene(load, friction=0.8))
    assert solution.dissipation == 0
    assert solution.steady_from is not None


@given(
    st.floats(0.05, 0.9),
    st.floats(0.05, 0.95),
    st.floats(5, 175),
    st.lists(st.tuples(st.floats(0.1, 3.0), st.floats(-0.95, 0.95)), max_size=4),
)
@settings(max_examples=25)
def test_the_start_is_forgotten(ratio, use, phase, detours):
    """The steady cycle dissipates the same whatever admissible polygon led to it."""
    friction = 0.7
    amplitude = use * friction * (1 - ratio)
    straight = solve(make_scene(ellipse(1.0, ratio, 0.0, amplitude, phase), friction=friction), fields=("dissipation",))
    initial_loading = tuple((p, friction * p * share) for p, share in detours)
    other = solve(
        make_scene(ellipse(1.0, ratio, 0.0, amplitude, phase, initial_loading), friction=friction), fields=("dissipation",)
    )
    assert other.steady_from is not None
    assert other.dissipation == pytest.approx(straight.dissipation, rel=1e-10, abs=1e-15)
    # The dissipation of an ellipse is by formula; the closed integral goes through the memory that the initial loading left.
    assert other.loop_work == pytest.approx(straight.dissipation, rel=1e-9, abs=1e-14)


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ([[0, 1, 0], [1, 2, 3.0]], r"gross sliding from time 0\.5 on, at time 1 with P = 2, Q = 3, f = 1:"),
        ([[0, 1, 0], [1, -1, 0]], r"separation from time 0\.5 on, at time 1 with P = -1, Q = 0:"),
    ],
)
def test_inadmissible_rows_are_refused_with_the_instant(rows, why):
    with pytest.raises(InadmissibleLoadError, match=why):
        solve(make_scene(TimeSeriesLoad(rows=rows), friction=1.0))


@pytest.mark.parametrize("repeats", [False, True])
def test_an_instant_outside_the_rows_is_refused(repeats):
    load = TimeSeriesLoad(rows=[[1, 2, 0.5], [2, 1, 0], [3, 2, 0.5]], repeats=repeats)
    with pytest.raises(InputError, match="time: outside the load path, which runs from"):
        solve(make_scene(load), time=[-3.0, 1.0])
    if not repeats:
        with pytest.raises(InputError, match="outside the load path"):
            solve(make_scene(load), time=[3.5])


def test_full_unloading_and_loading_again():
    rows = [[0, 1, 0.6], [1, 0, 0], [2, 1, 0.1]]
    scene = make_scene(TimeSeriesLoad(rows=rows), friction=0.7)
    assert solve(scene).dissipation == pytest.approx(by_spans(scene, fields=("dissipation",)).dissipation, rel=1e-11, abs=0)


CORNERED = {
    "compound": Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=1.2),
    "wedge": Wedge(tip_radius=1.0, tip_half_length=0.9),
    "table": Tabulated(points=[[float(x), float(np.cosh(x) - 1)] for x in np.linspace(0, 4, 21)]),
}


@pytest.mark.parametrize("profile", CORNERED.values(), ids=CORNERED)
def test_rows_over_corners_of_the_profile_dissipate_what_legs_do(profile):
    """Two rules of quadrature, 2e-15 apart; 5e-8 and 3e-7 in W(x) where those of rows did not know of the corners."""
    draw, count = np.random.default_rng(3), 40
    time = 0.2 * np.arange(count)
    normal = 1.5 + 0.5 * np.cos(time) * draw.uniform(0.6, 1.0, count)
    tangential = 0.4 * normal * np.sin(0.7 * time + 0.3 * draw.normal(size=count))
    rows = np.column_stack([time, normal, tangential]).tolist()
    scene = make_scene(TimeSeriesLoad(rows=rows)).vary(profile=profile)
    x = np.linspace(0.8, 1.5, 8)
    asked = ("dissipation", "dissipation_density")
    one, other = by_spans(scene, x=x, fields=asked), solve(scene, x=x, fields=asked)
    assert other.dissipation == pytest.approx(one.dissipation, rel=1e-11, abs=0)
    np.testing.assert_allclose(
        other.dissipation_density, one.dissipation_density, rtol=0, atol=1e-11 * np.max(one.dissipation_density)
    )
    assert 1e-11 > other.record.errors["dissipation"] > abs(other.dissipation / one.dissipation - 1)


# Dissipation over A f^2 P_ref^2 of the steady cycle, P_ref the mean load (the largest for the record): two routes agree to 1e-11.
LIBRARY = {
    "compound-curvature": 0.017631927430290,
    "rounded-wedge": 0.053740155369005,
    "other-sense": 0.014453805875244,
    "phase-45": 0.035999746446072,
    "phase-150-other-sense": 0.014993937114155,
    "near-sliding": 0.286342268533642,
    "tiny-slip": 1.0663701634e-07,
    "harmonics": 0.020148339024898,
    "time-series": 0.011534818147979,
}


@pytest.mark.parametrize("name", LIBRARY)
def test_library_scenes_dissipate_what_they_did(name):
    scene = load_scene(name)
    solution = solve(scene, x=[0.5], fields=("dissipation",))
    modulus, friction = 210e3 / (2 * 0.91), scene.friction.coefficient
    load = getattr(scene.load, "mean_normal_load", float(np.max(solution.normal_load)))
    dimensionless = solution.dissipation * modulus / (2 * friction**2 * load**2)
    assert dimensionless == pytest.approx(LIBRARY[name], rel=1e-8)
    if name != "time-series":
        assert solution.steady_from == 1
        assert solution.loop_work == pytest.approx(solution.dissipation, rel=1e-9, abs=0)
