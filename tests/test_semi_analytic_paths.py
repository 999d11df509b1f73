"""Load paths: harmonics, functions and rows against ellipse, polygon and each other; steady states, long series, refusals."""

import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from scenes import (
    CallableLoad,
    HarmonicLoad,
    Tabulated,
    TimeSeriesLoad,
    load_scene,
)
from semi_analytic import FIELDS, load_series, profiles, solution, solve
from semi_analytic.elasticity import composite_modulus
from semi_analytic.friction_work import closed_integral, global_dissipation
from semi_analytic.history import history_of
from semi_analytic.load_series import follow, knots_of
from semi_analytic.profiles import contact_of
from semi_analytic_cases import ellipse, make_scene, polygon


def by_spans(scene, **options):
    """The answer by the engine of curved paths."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solution, "own_series", lambda scene, time: None)
        return solve(scene, **options)


def series_of(path, count):
    """A cycle as rows on the path, closed to the last digit."""
    time = np.linspace(path.cycle_start, path.cycle_start + path.period, count)
    rows = np.stack([time, *path.at(time)], axis=1)
    rows[-1, 1:] = rows[0, 1:]
    return TimeSeriesLoad(rows=rows, repeats=True)


THREE = HarmonicLoad(
    mean_normal_load=3,
    mean_tangential_load=0.3,
    normal_harmonics=[(0.8, 0), (0.3, 40), (0.2, -70)],
    tangential_harmonics=[(0.7, 90), (0.4, 10), (0.1, 100)],
)
X = np.linspace(0, 2.3, 12)
TURN = 2 * math.pi
ANGLES = TURN * np.linspace(0, 1, 41)


def as_harmonics(phase):
    """A second wave of no size takes the routines for several waves."""
    return HarmonicLoad(
        mean_normal_load=3.0,
        mean_tangential_load=0.4,
        normal_harmonics=[(1.0, 0.0), (1e-300, 0.0)],
        tangential_harmonics=[(1.0, phase)],
    )


def as_functions(phase):
    lag = math.radians(phase)
    return CallableLoad(
        normal_load=lambda t: 3 + np.cos(t), tangential_load=lambda t: 0.4 + np.cos(t - lag), duration=TURN, repeats=True
    )


# --------------------------------------------------------------------------------------- one path in several forms


@pytest.mark.parametrize(
    ("load", "phase", "flat"), [(as_harmonics, 90.0, 0.7), (as_harmonics, -120.0, 0.0), (as_functions, -120.0, 0.7)]
)
def test_an_ellipse_in_other_clothes_is_the_same(load, phase, flat):
    """Tractions, slips, shift and dissipation of the steady cycle, by substitution in time and by the ellipse's own.

    The two share neither turning points (searched, closed form) nor quadratures on appended arcs. Measured: 2e-13.
    """
    known = make_scene(ellipse(3.0, 1.0, 0.4, 1.0, phase), 1.0, flat)
    other = make_scene(load(phase), 1.0, flat)
    half = float(contact_of(known.profile, known.material).half_width(4.0))
    x = half * np.linspace(0, 1.093, 23)
    begin = TURN * (2 + math.ceil(known.load.path().cycle_start / TURN))
    one, two = (solve(scene, x=x, time=begin + ANGLES) for scene in (known, other))
    assert two.steady_from == 1
    assert two.dissipation == pytest.approx(one.dissipation, rel=1e-12, abs=0)
    assert two.loop_work == pytest.approx(one.dissipation, rel=1e-12, abs=0)
    # What lies inside the permanent stick zone is the initial loading's, and that differs.
    outside = x > one.permanent_stick_half_width * (1 + 1e-9)
    np.testing.assert_allclose(two.shear[:, outside], one.shear[:, outside], atol=2e-12)
    np.testing.assert_allclose(two.slip - two.slip[0], one.slip - one.slip[0], atol=2e-12)
    np.testing.assert_allclose(
        two.tangential_displacement - two.tangential_displacement[0],
        one.tangential_displacement - one.tangential_displacement[0],
        atol=2e-12,
    )
    np.testing.assert_allclose(two.dissipation_density, one.dissipation_density, atol=1e-11 * np.max(one.dissipation_density))
    np.testing.assert_array_equal(two.state[1:-1], one.state[1:-1])


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


WAVES = st.tuples(st.floats(0.0, 1.0), st.floats(-180, 180))


# Newton's method gave up after three bisections that gained nothing: a crossing of the memory curve 0.02 late, W 3.3e-4 off.
@example([(0.5, 0.0), (0.609375, -109.875), (0.34765625, 31.75)], [(1.0, -29.0)], 0.5, 0.125)
@settings(max_examples=4)
@given(st.lists(WAVES, min_size=1, max_size=3), st.lists(WAVES, min_size=1, max_size=3), st.floats(0.1, 0.9), st.floats(0.1, 0.9))
def test_harmonics_balance_their_energy(normal, tangential, squeeze, use):
    """Closed integral of Q dU against the slip integral for up to three harmonics, and M(P) = Q at every instant."""
    sizes = [sum(amplitude for amplitude, _ in waves) or 1.0 for waves in (normal, tangential)]
    normal = [(squeeze * (amplitude / sizes[0]), phase) for amplitude, phase in normal]
    tangential = [(use * 0.5 * (1 - squeeze) * (amplitude / sizes[1]), phase) for amplitude, phase in tangential]
    scene = make_scene(HarmonicLoad(mean_normal_load=1.0, normal_harmonics=normal, tangential_harmonics=tangential), 0.5)
    history = history_of(scene.load.path(), 0.5, 6)
    assert history.steady_from is not None
    contact, modulus = contact_of(scene.profile, scene.material), composite_modulus(scene.material)
    spans = history.cycles[-1]
    work = float(global_dissipation(contact, modulus, spans).total)
    assert closed_integral(contact, modulus, spans)[0] == pytest.approx(work, rel=1e-9, abs=1e-13)
    solution = solve(scene, x=[0.0], fields=(), time=8 * np.pi + ANGLES)
    assert np.max(solution.record.certificates["tangential_balance"]) < 1e-11


CORNERS = [(2.0, 0.0), (2.0, 0.7), (1.2, -0.1), (2.5, -0.6), (2.0, 0.0)]


def test_rows_and_functions_with_corners_are_the_polygon():
    rows = [[float(k), *corner] for k, corner in enumerate(CORNERS)]
    plain = make_scene(polygon(CORNERS[:1], CORNERS[1:-1]), 0.5)
    series = make_scene(TimeSeriesLoad(rows=rows, repeats=True), 0.5)
    normal, tangential = (lambda t, k=k: np.interp(np.mod(t, 4), range(5), [corner[k] for corner in CORNERS]) for k in (0, 1))
    function = make_scene(CallableLoad(normal_load=normal, tangential_load=tangential, duration=4.0, repeats=True), 0.5)
    x = np.linspace(0, 1.8, 7)
    one, two = solve(plain, x=x, time=np.linspace(1.0, 9.0, 33)), solve(series, x=x, time=np.linspace(0.0, 8.0, 33))
    for name in ("shear", "slip"):
        np.testing.assert_allclose(getattr(two, name), getattr(one, name), atol=1e-14)
    assert two.dissipation == pytest.approx(one.dissipation, rel=1e-13, abs=0)
    assert two.steady_from == one.steady_from
    assert solve(function, x=[0.0], fields=("dissipation",)).dissipation == pytest.approx(one.dissipation, rel=1e-11, abs=0)


def test_a_function_that_only_grows_sticks():
    scene = make_scene(
        CallableLoad(normal_load=lambda t: 1 - np.exp(-t), tangential_load=lambda t: 0.2 * np.sin(t), duration=1.0), 0.5
    )
    solution = solve(scene, x=[0.0, 0.3])
    assert solution.dissipation == 0
    assert np.max(solution.record.certificates["tangential_balance"]) < 1e-13


FIELDS_TO_COMPARE = ("pressure", "shear", "slip", "tangential_displacement", "normal_approach")


@pytest.mark.parametrize("repeats", [False, True])
@given(data=st.data(), flat=st.sampled_from([0.0, 0.5]))
@settings(max_examples=12)
def test_rows_as_a_series_are_rows_as_a_curved_path(repeats, data, flat):
    """The lean way and the general one: every field, at rows and between them."""
    corners = data.draw(st.lists(st.tuples(st.floats(0.05, 1.0), st.floats(-0.97, 0.97)), min_size=2, max_size=25, unique=True))
    friction, top = 0.7, max(p for p, _ in corners)
    rows = [[k + 1.0, p, friction * p * use] for k, (p, use) in enumerate(corners)]
    rows += [[len(rows) + 1.0, *rows[0][1:]]] * repeats
    scene = make_scene(TimeSeriesLoad(rows=rows, repeats=repeats), friction=friction, flat=flat)
    # Not at the middle of a step: that may be where nothing slips for an instant, which both may call as they like.
    time = np.arange(1.0, len(rows) + 1.9 * repeats, 0.37)
    lean, full = solve(scene, time=time, x=X[:5]), by_spans(scene, time=time, x=X[:5])
    scale = {"dissipation": (friction * top) ** 2, "cycle_dissipation": (friction * top) ** 2, "dissipation_density": top}
    for name in (*FIELDS_TO_COMPARE, *scale):
        one, two = getattr(lean, name), getattr(full, name)
        np.testing.assert_allclose(one, two, rtol=1e-10, atol=1e-11 * scale.get(name, max(top, 1.0)), err_msg=name)
    # c is the root of P_c: a last digit of P counts for 1e-8 there.
    np.testing.assert_allclose(*(np.nan_to_num(each.stick_half_width, nan=flat) for each in (lean, full)), atol=1e-7)
    assert lean.steady_from == full.steady_from
    assert np.max(lean.record.certificates["tangential_balance"]) < 1e-13


def rows_along_the_limit(seed):
    """Rows along the limit of friction and back along their own lines: loads, and whether they repeat."""
    draw = np.random.default_rng(seed)
    count, repeats = int(draw.integers(2, 14)), bool(seed % 2)
    normal = draw.choice([0.25, 0.5, 0.75, 1.0], count)
    loads = np.column_stack([normal, 0.7 * normal * draw.choice([-1, -0.5, 0, 0.25, 0.5, 1], count)]).tolist()
    return loads + loads[:1] * repeats, repeats


BY_BOTH = {f"along the limit {seed}": rows_along_the_limit(seed) for seed in range(6)} | {
    # |Q| = f P is reached and P_c was a last digit below 0: W(x) on a flat face was no number.
    "a front at no load": (
        [(1.0, 0.0), (0.5, 0.0875), (1.0, -0.7), (0.25, 0.04375), (0.75, 0.5249999999999999), (0.5, 0.175), (0.75, 0.0)],
        False,
    ),
    "unloaded and loaded again": ([(1, 0.6), (0, 0), (1, 0.1)], False),
    # However far P goes: what counts is how deep the front of slip went, 1e-12 of P and less.
    "hardly slips": ([(0.92, 0.644e-12), (0.5, 0.0), (0.92, 0.644e-12)], True),
    "hardly slips, four turns": (
        [(0.5, 0.0), (0.512062, 3.58e-10), (1.0, -7e-13), (0.05, 7e-18), (0.73, -5.11e-13), (0.5, 0.0)],
        True,
    ),
}


@pytest.mark.parametrize("flat", [0.0, 0.5])
@pytest.mark.parametrize("name", BY_BOTH)
def test_rows_at_the_ends_of_friction_are_followed_alike_by_both_ways(name, flat):
    loads, repeats = BY_BOTH[name]
    scene = make_scene(TimeSeriesLoad(rows=[[k, *load] for k, load in enumerate(loads)], repeats=repeats), 0.7, flat)
    time = np.sort(np.random.default_rng(1).uniform(0, len(loads) - 1, 9))
    one, other = (way(scene, x=X[:7], time=time) for way in (solve, by_spans))
    assert one.steady_from == other.steady_from == (1 if "hardly" in name else other.steady_from)
    if "hardly" not in name:  # which of them slips is rounding
        np.testing.assert_array_equal(one.state, other.state)
    for field in ("slip", "tangential_displacement", "dissipation", "cycle_dissipation", "dissipation_density"):
        np.testing.assert_allclose(getattr(one, field), getattr(other, field), rtol=0, atol=1e-13, err_msg=field)
    assert one.dissipation == pytest.approx(other.dissipation, rel=1e-3 if "hardly" in name else 1e-11, abs=0)


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


# -------------------------------------------------------------------------------------------------------- steady states


# -------------------------------------------------------------------------------------------------- long series, and effort


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


def test_what_is_alive_stays_small_however_many_steps_went_before():
    """A larger swing erases the smaller ones, every knot comes and goes once; dying swings stay until one erases them."""
    rng = np.random.default_rng(3)
    normal = rng.uniform(1.0, 3.0, 16000)
    block = follow(None, np.stack([normal, rng.uniform(-0.9, 0.9, 16000) * normal], axis=1), 1.0)
    assert (len(block.records.row) <= 2 * 16000, block.alive < 40) == (True, True)
    swings = np.array([(-1) ** k * 0.6 * (1 - k / 1001) for k in range(1000)])
    rows = np.stack([np.r_[0.0, np.ones(1001)], np.r_[0.0, 0.0, swings]], axis=1)
    curve = follow(None, rows, 1.0).curve
    assert 900 < len(knots_of(curve)[0]) <= 1003
    curve = follow(curve, np.array([rows[-1], [1.0, 0.65]]), 1.0).curve
    assert len(knots_of(curve)[0]) <= 3


def test_what_instants_share_of_an_arc_is_integrated_once(monkeypatch):
    """Closed-int Q dU of harmonics on a table of 13 rows: each instant integrated its arc from the start, over every knot."""
    inverted = []
    law = profiles.tabulated

    def counted(modulus, profile):
        found = law(modulus, profile)

        def advance(load):
            inverted.append(np.size(load))
            return found.advance(load)

        return replace(found, advance=advance)

    monkeypatch.setattr(profiles, "tabulated", counted)
    x = np.linspace(0.0, 6.0, 13)
    profile = Tabulated(points=np.column_stack([x, np.cosh(x / 3) - 1]).tolist())
    load = HarmonicLoad(
        mean_normal_load=0.8,
        mean_tangential_load=0.0,
        normal_harmonics=[(0.5, 0.0)],
        tangential_harmonics=[(0.05, 40.0), (0.02, -60.0)],
    )
    scene = make_scene(load, 0.3).vary(profile=profile)
    answer = solve(scene, x=[0.0], fields=("dissipation",))
    assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-12, abs=0)
    assert sum(inverted) < 4e6  # 2.0e6, and 7.0e7 before
