"""Memory and events of a path: properties on random paths, the brute-force stepping of the theory, edges straight from the path."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes import (
    InputError,
    LoadPath,
    StraightSegment,
    TimeSeriesLoad,
    load_scene,
)
from semi_analytic import event, events
from semi_analytic.history import Turn, follow, history_of
from semi_analytic.memory import pieces, same, unload_to, values
from semi_analytic_cases import LOADS, ellipse, extreme, make_scene, polygon
from semi_analytic_oracle import LONG, Work, memory, phases_of

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


@given(CORNERS, st.integers(0, 11), st.floats(0.01, 0.99), st.floats(0.02, 0.9), st.floats(-0.9, 0.9))
def test_the_curve_is_what_stepping_leaves_whatever_the_steps(points, where, part, low, use):
    """By brute force; Lipschitz, at the load; a step may be split; mirrored; what lies above the load is forgotten."""
    curve, (normal, tangential) = final_curve(points), points[-1]
    phases, _ = phases_of(LoadPath(tuple(straight_legs(points)), ()), FRICTION, 0)
    eta = normal * np.array([1e-3, 0.2, 0.5, 0.8])
    held = [float(memory(phases, len(phases) - 1, phases[-1].end, each, FRICTION)) for each in eta]
    np.testing.assert_allclose(values(curve, eta), held, rtol=0, atol=1e-14)
    assert curve.top == pytest.approx(normal, rel=1e-15)
    assert float(values(curve, curve.top)) == pytest.approx(tangential, abs=1e-14)
    knots = np.array([0.0, *(piece.top for piece in pieces(curve))][1:][::-1])
    eta = np.unique(np.concatenate([np.linspace(0, normal, 50), knots]))
    assert np.all(np.abs(np.diff(values(curve, eta)) / np.maximum(np.diff(eta), 1e-9)) <= FRICTION * (1 + 1e-9) + 1e-6)
    np.testing.assert_allclose(values(final_curve([(p, -q) for p, q in points]), eta), -values(curve, eta), atol=1e-14)
    corners, where = [(0.0, 0.0), *points], min(where, len(points) - 1)
    extra = tuple(a + part * (b - a) for a, b in zip(corners[where], corners[where + 1], strict=True))
    assert same(curve, final_curve([*points[:where], extra, *points[where:]]), FRICTION, tolerance=1e-11)
    unloaded = final_curve([*points, (low * normal, low * normal * FRICTION * use)])
    assert all(piece.top <= low * normal * (1 + 1e-15) for piece in pieces(unloaded))


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


def test_curves_are_told_apart_and_unloading_follows_them():
    curve = final_curve([(1.0, 0.3), (2.0, 0.4)])
    assert same(unload_to(curve, 0.5), final_curve([(0.5, 0.15)]), FRICTION)
    assert same(final_curve([(1.0, 0.3), (2.0, 0.4), (1.0, 0.3)]), final_curve([(1.0, 0.3)]), FRICTION)
    assert unload_to(curve, 0.0) is None
    assert same(final_curve([(1.0, 0.6), (0.0, 0.0), (1.0, 0.1)]), final_curve([(1.0, 0.1)]), FRICTION)
    for other in ([(1.0, 0.3 + 1e-9)], [(0.5, 0.1), (1.0, 0.3)]):
        assert not same(final_curve([(1.0, 0.3)]), final_curve(other), FRICTION)
    assert not same(final_curve([(1.0, 0.3)]), None, FRICTION)


def test_pieces_stay_few_while_the_steps_grow():
    """1,000 decaying turns and then a large one: memory grows with what is alive, not with what has been."""
    swings = [(1.0, (-1) ** k * 0.6 * (1 - k / 1001)) for k in range(1000)]
    assert 900 < sum(1 for _ in pieces(final_curve(swings))) <= 1002
    assert sum(1 for _ in pieces(final_curve([*swings, (1.0, 0.65)]))) <= 3


# ------------------------------------------------------------------------------------------ edges of slip and memory by brute force


def slipped_at(work, span, time):
    """P - P_c by brute force."""
    phases = [k for k, phase in enumerate(work.phases) if phase.leg == span.leg and phase.begin <= time <= phase.end]
    slips = [slip for slip in work.slips if slip.phase.leg == span.leg and slip.begin <= time <= slip.end]
    # A path along the limit of friction moves no front: rounding of Q - f P says whether there is one.
    slips = [slip for slip in slips if np.diff(slip.growth(np.array([slip.begin, slip.end]))[0])[0] > 1e-15]
    return max((float(slip.phase.loads(time)[0] - slip.front(time)) for slip in slips), default=0.0), phases[-1]


@pytest.mark.parametrize("load", LOADS)
def test_fronts_and_the_memory_curve_straight_from_the_path(load):
    """P_c to 1e-14 of P, M(eta) to 1e-15 f P. Just after a turn on harmonics P_c was 1.2e-11 off, 1/5,000 of what had slipped."""
    scene = extreme("hertz", load)
    history = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles)
    work, top, checked = Work(scene, history.covered[-1]), 2.0, 0
    for span in history.cycles[-1]:
        for part in (1e-4, 0.1, 0.6, 0.999):
            time = LONG(span.begin.time + (span.end.time - span.begin.time) * part)
            if time - span.begin.time < 1e-7:  # what brute force itself knows so soon after a turn has less digits
                continue
            slipped, number = slipped_at(work, span, time)
            assert abs(float(span.slipped(float(time))) - slipped) <= 1e-14 * top, (span.begin.time, part)
            eta = float(span.leg.loads(float(time))[0]) * np.array([1e-3, 0.3, 0.9])
            exact = [float(memory(work.phases, number, time, each, 0.5)) for each in eta]
            np.testing.assert_allclose(values(span.curve(float(time)), eta), exact, rtol=0, atol=1e-15 * 0.5 * top)
            checked += 1
    assert checked >= 12


# -------------------------------------------------------------------------------------------------------------------- events


PAPER = make_scene(ellipse(3.0, 1.0, 1.1, 1.0, 90.0, "parabola"))
ROOT = math.sqrt(0.5)


# P = 3 + cos t, Q = 1.1 + sin t, f = 1: u = Q - P turns at 3 pi/4 and 7 pi/4, v = Q + P at pi/4 and 5 pi/4.
PLACES = {
    "A": (3.0, 0.1),
    "B": (3 + ROOT, 1.1 - ROOT),
    "C": (4.0, 1.1),
    "D": (3.0, 2.1),
    "E": (3 - ROOT, 1.1 + ROOT),
    "F": (2.0, 1.1),
    "G": (3 - ROOT, 1.1 - ROOT),
    "H": (3.0, 0.1),
    "I": (3 + ROOT, 1.1 - ROOT),
    "J": (3 + ROOT, 1.1 + ROOT),
    "K": (4.0, 1.1),
    "L": (3.0, 2.1),
    "M": (3 - ROOT, 1.1 + ROOT),
}


@pytest.mark.parametrize("sense", [1, -1])
def test_letters_stand_where_the_circle_says(sense):
    """And clockwise at the mirror image. J comes after K, which the paper names after it: 2 t_I - t_G = 9 pi/4."""
    scene = PAPER if sense > 0 else make_scene(ellipse(3.0, 1.0, -1.1, 1.0, -90.0))
    for letter, (normal, tangential) in PLACES.items():
        found = event(scene, letter)
        assert (found.normal_load, sense * found.tangential_load) == pytest.approx((normal, tangential), abs=1e-12), letter
        assert scene.load.path().at(found.time) == pytest.approx((normal, sense * tangential), abs=1e-12)
    times = [one.time for one in events(PAPER)]
    assert "".join(one.letter for one in events(PAPER)) == "ABCDEFGHIKJLM"
    assert times == sorted(times)


def test_events_have_the_names_and_edge_loads_of_the_paper():
    """At E the transient edge load (its Z); at G and M the permanent stick load T; at J the load of G; in full stick P itself."""
    permanent = 3 - math.sqrt(2)
    assert event(PAPER, "G").front_load == event(PAPER, "M").front_load == pytest.approx(permanent, rel=1e-14)
    assert event(PAPER, "E").front_load < permanent < event(PAPER, "L").front_load < 3 - ROOT
    assert event(PAPER, "J").front_load == pytest.approx(3 - ROOT)
    assert event(PAPER, "H").front_load == event(PAPER, "H").normal_load
    assert event(PAPER, "B").name == "full stick ends, forward slip starts"
    assert event(PAPER, "E").name == "forward slip ends, reverse slip starts"
    assert "Q least" in event(PAPER, "A").name
    assert "P largest" in event(PAPER, "C").name


def test_lines_polygons_and_series_have_events_without_letters():
    series = make_scene(TimeSeriesLoad(rows=[[0.0, 0.0, 0.0], [1.0, 1.0, 0.2], [2.0, 0.5, -0.1]]))
    assert [one.time for one in events(series)] == [0.0, 1.0, 2.0]
    for scene in (load_scene("full-stick"), make_scene(polygon([(1.0, 0.0)], [(1.0, 0.4), (1.0, -0.4)])), series):
        assert all(one.letter == "" for one in events(scene))
        with pytest.raises(InputError, match="no event 'A'"):
            event(scene, "A")
