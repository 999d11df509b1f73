"""The memory curve: its defining properties on random paths, and the brute-force stepping of the theory as an oracle."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes import NORMAL_LOAD, Combination, StraightSegment, ellipse_segment, parabola_segment
from semi_analytic.history import Turn, follow, monotonic_parts
from semi_analytic.memory import instant, level, pieces, same, unload_to, values
from semi_analytic_cases import brute_force_curve, ellipse

FRICTION = 0.7
CORNERS = st.lists(
    st.tuples(st.floats(0.05, 1.0), st.floats(-0.98, 0.98)).map(lambda point: (point[0], point[0] * FRICTION * point[1])),
    min_size=1,
    max_size=12,
)


def straight_legs(points):
    corners = [(0.0, 0.0), *points]
    return [StraightSegment(float(k), k + 1.0, corners[k], corners[k + 1]) for k in range(len(points))]


def final_curve(points):
    return follow(straight_legs(points), [], FRICTION).states[0]


@given(CORNERS)
def test_curve_is_lipschitz_and_ends_at_the_load(points):
    curve = final_curve(points)
    normal, tangential = points[-1]
    assert curve.top == pytest.approx(normal, rel=1e-15)
    assert float(values(curve, curve.top)) == pytest.approx(tangential, abs=1e-14)
    knots = np.array([0.0, *(piece.top for piece in pieces(curve))][1:][::-1])
    eta = np.unique(np.concatenate([np.linspace(0, normal, 50), knots]))
    slopes = np.diff(values(curve, eta)) / np.maximum(np.diff(eta), 1e-9)
    assert np.all(np.abs(slopes) <= FRICTION * (1 + 1e-9) + 1e-6)


@given(CORNERS)
def test_curve_is_what_brute_force_stepping_leaves(points):
    eta, held = brute_force_curve(points, FRICTION)
    np.testing.assert_allclose(values(final_curve(points), eta), held, atol=3e-4 * FRICTION)  # the oracle's grid: 1/4000


@given(CORNERS, st.integers(0, 11), st.floats(0.01, 0.99))
def test_splitting_a_straight_step_changes_nothing(points, where, part):
    corners = [(0.0, 0.0), *points]
    where = min(where, len(points) - 1)
    first, last = corners[where], corners[where + 1]
    extra = tuple(a + part * (b - a) for a, b in zip(first, last, strict=True))
    split = [*points[:where], extra, *points[where:]]
    assert same(final_curve(points), final_curve(split), FRICTION, tolerance=1e-11)


@given(CORNERS)
def test_mirrored_path_has_mirrored_memory(points):
    eta = np.linspace(0, points[-1][0], 30)
    mirrored = [(p, -q) for p, q in points]
    np.testing.assert_allclose(values(final_curve(mirrored), eta), -values(final_curve(points), eta), atol=1e-14)


@given(CORNERS, st.floats(0.02, 0.9), st.floats(-0.9, 0.9))
def test_what_lies_above_the_load_is_forgotten(points, low, use):
    """Unloading along a line of slope 0 leaves nothing of the memory above it."""
    final = (low * points[-1][0], low * points[-1][0] * FRICTION * use)
    curve = final_curve([*points, final])
    assert curve.top == pytest.approx(final[0])
    assert all(piece.top <= final[0] * (1 + 1e-15) for piece in pieces(curve))


@given(st.floats(1e-3, 0.95), st.floats(0.02, 0.98), st.floats(5, 175), st.floats(-0.5, 0.5), st.sampled_from([1.0, -1.0]))
def test_initial_loading_does_not_matter_above_the_permanent_stick_load(ratio, use, phase, mean, sense):
    """Three admissible initial loadings, one steady cycle: the curves differ only below P_T."""
    slack = (1 - ratio) * (1 - use)
    q1, q0 = use * FRICTION * (1 - ratio), mean * slack * FRICTION
    ends = []
    for initial_loading in ("straight", ((1.2, 0.0),), ((0.7, 0.5 * 0.7 * FRICTION), (1.0, -0.4 * FRICTION))):
        path = ellipse(1.0, ratio, q0, q1, sense * phase, initial_loading).path()
        history = follow(path.initial_loading, [Turn(path.cycle, 2 * np.pi * k) for k in range(4)], FRICTION)
        assert history.steady_from in (0, 1)
        fronts = [
            span.leg.loads(time)[0] - span.slipped(time) for span in history.cycles[-1] for time in (span.begin.time, span.end.time)
        ]
        ends.append((history.states[-1], float(min(fronts))))
    eta = np.linspace(ends[0][1], ends[0][0].top, 40)
    for curve, permanent in ends[1:]:
        assert permanent == pytest.approx(ends[0][1], rel=1e-9, abs=1e-12)
        np.testing.assert_allclose(values(curve, eta), values(ends[0][0], eta), atol=1e-9)


def test_ellipse_is_the_limit_of_polygons():
    """The same curve, from arcs and from 20,000 straight steps."""
    path = ellipse(3.0, 1.0, 1.1, 1.0, 90.0).path()
    time = np.linspace(path.cycle_start, path.cycle_start + 2 * np.pi, 20001)
    points = list(zip(*(part.tolist() for part in path.at(time)), strict=True))
    eta = np.linspace(0, points[-1][0], 1000)
    exact = follow(path.initial_loading, [Turn(path.cycle)], 1.0).states[-1]
    straight = [StraightSegment(k, k + 1.0, points[k - 1], points[k]) for k in range(1, len(points))]
    rough = follow([*path.initial_loading, *straight], [], 1.0).states[0]
    np.testing.assert_allclose(values(exact, eta), values(rough, eta), atol=3e-8)


def test_unloading_along_the_curve_leaves_it_and_full_unloading_leaves_nothing():
    curve = final_curve([(1.0, 0.3), (2.0, 0.4)])
    assert same(unload_to(curve, 0.5), final_curve([(0.5, 0.15)]), FRICTION)
    assert same(final_curve([(1.0, 0.3), (2.0, 0.4), (1.0, 0.3)]), final_curve([(1.0, 0.3)]), FRICTION)
    assert unload_to(curve, 0.0) is None
    assert same(final_curve([(1.0, 0.6), (0.0, 0.0), (1.0, 0.1)]), final_curve([(1.0, 0.1)]), FRICTION)


def test_curves_that_differ_are_told_apart():
    assert not same(final_curve([(1.0, 0.3)]), final_curve([(1.0, 0.3 + 1e-9)]), FRICTION)
    assert not same(final_curve([(1.0, 0.3)]), final_curve([(0.5, 0.1), (1.0, 0.3)]), FRICTION)
    assert not same(final_curve([(1.0, 0.3)]), None, FRICTION)


def test_pieces_stay_few_while_the_steps_grow():
    """1,000 decaying turns and then a large one: memory grows with what is alive, not with what has been."""
    swings = [(1.0, (-1) ** k * 0.6 * (1 - k / 1001)) for k in range(1000)]
    assert 900 < sum(1 for _ in pieces(final_curve(swings))) <= 1002
    assert sum(1 for _ in pieces(final_curve([*swings, (1.0, 0.65)]))) <= 3


LEGS = [
    StraightSegment(0.0, 2.0, (1.0, 0.2), (3.0, -0.4)),
    parabola_segment(0.0, 2.0, (3.0, 0.6), -0.3),
    ellipse_segment(0.5, 6.0, (3.0, 0.1), (1.0, 0.7), 1.1),
]


@pytest.mark.parametrize("leg", LEGS, ids=lambda leg: type(leg).__name__)
@pytest.mark.parametrize("what", [NORMAL_LOAD, Combination(0.0, 1.0), level(1, 0.7), level(-1, 0.7)])
def test_combinations_turn_where_they_say_and_inverses_invert(leg, what):
    for begin, end in monotonic_parts(leg, 0.7):
        times = np.linspace(begin, end, 41)
        steps = np.diff(leg.change_of(what, times, begin))
        if what.normal:
            assert np.all(steps >= 0) or np.all(steps <= 0)
            inverse = leg.time_of(what, leg.change_of(what, times, begin), begin, end)
            np.testing.assert_allclose(leg.change_of(what, inverse, begin), leg.change_of(what, times, begin), atol=2e-15)


def test_the_closed_forms_of_one_wave_are_what_the_general_routines_find():
    """A second wave of no size takes the routines for several: turning points by eigenvalues, times by Newton's method."""
    known = LEGS[2]
    general = replace(known, normal=(*known.normal, (1e-300, 0.0)))
    assert known.ellipse
    assert not general.ellipse
    np.testing.assert_allclose(monotonic_parts(general, 0.7), monotonic_parts(known, 0.7), atol=1e-14)
    begin, end = monotonic_parts(known, 0.7)[1]
    amount = np.linspace(0, float(known.change_of(NORMAL_LOAD, end, begin)), 7)
    np.testing.assert_allclose(
        general.time_of(NORMAL_LOAD, amount, begin, end), known.time_of(NORMAL_LOAD, amount, begin, end), atol=1e-12
    )


def test_instants_carry_their_loads():
    assert instant(LEGS[0], 1.0)[1:] == (1.0, 2.0, pytest.approx(-0.1))
