"""Histories: memory and events straight from the path; harmonics, functions and rows against each
other; long series.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize

from scenes import InputError, LoadPath, StraightSegment, TimeSeriesLoad, load_scene
from semi_analytic import FIELDS, answer_by_memory, event, events, solve
from semi_analytic.history import CycleOfPath, follow, history_of
from semi_analytic.memory import (
    force_up_to,
    is_same_memory,
    pieces,
)
from semi_analytic_cases import LOADS, ellipse, extreme, make_scene, polygon
from semi_analytic_oracle import LONG, Work, memory, phases_of

FRICTION = 0.7
CORNERS = st.lists(
    st.tuples(st.floats(0.05, 1.0), st.floats(-0.98, 0.98)).map(
        lambda point: (point[0], point[0] * FRICTION * point[1])
    ),
    min_size=1,
    max_size=12,
)


def straight_legs(points):
    corners = [(0.0, 0.0), *points]
    return [
        StraightSegment(float(k), k + 1.0, corners[k], corners[k + 1]) for k in range(len(points))
    ]


def final_curve(points):
    return follow(straight_legs(points), [], FRICTION).states[0]


@settings(max_examples=20)
@given(
    CORNERS, st.integers(0, 11), st.floats(0.01, 0.99), st.floats(0.02, 0.9), st.floats(-0.9, 0.9)
)
def test_the_curve_is_what_stepping_leaves_whatever_the_steps(points, where, part, low, use):
    """By brute force; Lipschitz, at the load; a step may be split; mirrored; what lies above the
    load is forgotten.
    """
    curve = final_curve(points)
    normal, tangential = points[-1]
    phases, _ = phases_of(LoadPath(tuple(straight_legs(points)), ()), FRICTION, 0)
    eta = normal * np.array([1e-3, 0.2, 0.5, 0.8])
    held = [float(memory(phases, len(phases) - 1, phases[-1].end, each, FRICTION)) for each in eta]
    np.testing.assert_allclose(force_up_to(curve, eta), held, rtol=0, atol=1e-14)
    assert curve.top_load == pytest.approx(normal, rel=1e-15)
    assert float(force_up_to(curve, curve.top_load)) == pytest.approx(tangential, abs=1e-14)
    knots = np.array([0.0, *(piece.top_load for piece in pieces(curve))][1:][::-1])
    eta = np.unique(np.concatenate([np.linspace(0, normal, 50), knots]))
    assert np.all(
        np.abs(np.diff(force_up_to(curve, eta)) / np.maximum(np.diff(eta), 1e-9))
        <= FRICTION * (1 + 1e-9) + 1e-6
    )
    np.testing.assert_allclose(
        force_up_to(final_curve([(p, -q) for p, q in points]), eta),
        -force_up_to(curve, eta),
        atol=1e-14,
    )
    corners = [(0.0, 0.0), *points]
    where = min(where, len(points) - 1)
    extra = tuple(
        a + part * (b - a) for a, b in zip(corners[where], corners[where + 1], strict=True)
    )
    assert is_same_memory(
        curve, final_curve([*points[:where], extra, *points[where:]]), FRICTION, tolerance=1e-11
    )
    unloaded = final_curve([*points, (low * normal, low * normal * FRICTION * use)])
    assert all(piece.top_load <= low * normal * (1 + 1e-15) for piece in pieces(unloaded))


@settings(max_examples=20)
@given(
    st.floats(1e-3, 0.95),
    st.floats(0.02, 0.98),
    st.floats(5, 175),
    st.floats(-0.5, 0.5),
    st.sampled_from([1.0, -1.0]),
)
def test_initial_loading_does_not_matter_above_the_permanent_stick_load(
    ratio, use, phase, mean, sense
):
    """Three admissible initial loadings, one steady cycle: the curves differ only below P_T."""
    slack = (1 - ratio) * (1 - use)
    q1 = use * FRICTION * (1 - ratio)
    q0 = mean * slack * FRICTION
    ends = []
    for initial_loading in (
        "straight",
        ((1.2, 0.0),),
        ((0.7, 0.5 * 0.7 * FRICTION), (1.0, -0.4 * FRICTION)),
    ):
        path = ellipse(1.0, ratio, q0, q1, sense * phase, initial_loading).path()
        history = follow(
            path.initial_loading,
            [CycleOfPath(path.cycle, 2 * np.pi * k) for k in range(4)],
            FRICTION,
        )
        assert history.steady_from in (0, 1)
        fronts = [
            span.segment.loads(time)[0] - span.slip_zone_load(time)
            for span in history.cycles[-1]
            for time in (span.begin.time, span.end.time)
        ]
        ends.append((history.states[-1], float(min(fronts))))
    eta = np.linspace(ends[0][1], ends[0][0].top_load, 40)
    for curve, permanent in ends[1:]:
        assert permanent == pytest.approx(ends[0][1], rel=1e-9, abs=1e-12)
        np.testing.assert_allclose(force_up_to(curve, eta), force_up_to(ends[0][0], eta), atol=1e-9)


# ---------------------------------------------------------- edges of slip and memory by brute force


def slipped_at(work, span, time):
    """P - P_c by brute force."""
    phases = [
        k
        for k, phase in enumerate(work.phases)
        if phase.leg == span.segment and phase.begin <= time <= phase.end
    ]
    slips = [
        slip
        for slip in work.slips
        if slip.phase.leg == span.segment and slip.begin <= time <= slip.end
    ]
    # A path along the limit of friction moves no front: rounding of Q - f P says whether there is
    # one.
    slips = [
        slip
        for slip in slips
        if np.diff(slip.growth(np.array([slip.begin, slip.end]))[0])[0] > 1e-15
    ]
    return (
        max((float(slip.phase.loads(time)[0] - slip.front(time)) for slip in slips), default=0.0),
        phases[-1],
    )


@pytest.mark.parametrize("load", LOADS)
def test_fronts_and_the_memory_curve_straight_from_the_path(load):
    """P_c to 1e-14 of P, M(eta) to 1e-15 f P. Just after a turn on harmonics P_c was 1.2e-11 off,
    1/5,000 of what had slipped.
    """
    scene = extreme("hertz", load)
    history = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles)
    work = Work(scene, history.covered[-1])
    top = 2.0
    checked = 0
    for span in history.cycles[-1]:
        for part in (1e-4, 0.1, 0.999):
            time = LONG(span.begin.time + (span.end.time - span.begin.time) * part)
            # what brute force itself knows so soon after a turn has less digits
            if time - span.begin.time < 1e-7:
                continue
            slipped, number = slipped_at(work, span, time)
            assert abs(float(span.slip_zone_load(float(time))) - slipped) <= 1e-14 * top, (
                span.begin.time,
                part,
            )
            eta = float(span.segment.loads(float(time))[0]) * np.array([1e-3, 0.3, 0.9])
            exact = [float(memory(work.phases, number, time, each, 0.5)) for each in eta]
            np.testing.assert_allclose(
                force_up_to(span.curve(float(time)), eta), exact, rtol=0, atol=1e-15 * 0.5 * top
            )
            checked += 1
    assert checked >= 12


# ------------------------------------------------------------------------------------------- events


PAPER = make_scene(ellipse(3.0, 1.0, 1.1, 1.0, 90.0, "parabola"))
ROOT = math.sqrt(0.5)


# P = 3 + cos t, Q = 1.1 + sin t, f = 1: u = Q - P turns at 3 pi/4 and 7 pi/4, v = Q + P at pi/4 and
# 5 pi/4.
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
    """And clockwise at the mirror image. J comes after K, which the paper names after it: 2 t_I -
    t_G = 9 pi/4.
    """
    scene = PAPER if sense > 0 else make_scene(ellipse(3.0, 1.0, -1.1, 1.0, -90.0))
    for letter, (normal, tangential) in PLACES.items():
        event_found = event(scene, letter)
        assert (event_found.normal_load, sense * event_found.tangential_load) == pytest.approx(
            (normal, tangential), abs=1e-12
        ), letter
        assert scene.load.path().at(event_found.time) == pytest.approx(
            (normal, sense * tangential), abs=1e-12
        )
    times = [event_in_order.time for event_in_order in events(PAPER)]
    assert "".join(event_in_order.letter for event_in_order in events(PAPER)) == "ABCDEFGHIKJLM"
    assert times == sorted(times)


def test_events_have_the_names_and_edge_loads_of_the_paper():
    """At E the transient edge load (its Z); at G and M the permanent stick load T; at J the load of
    G; in full stick P itself.
    """
    permanent = 3 - math.sqrt(2)
    assert (
        event(PAPER, "G").front_load
        == event(PAPER, "M").front_load
        == pytest.approx(permanent, rel=1e-14)
    )
    assert event(PAPER, "E").front_load < permanent < event(PAPER, "L").front_load < 3 - ROOT
    assert event(PAPER, "J").front_load == pytest.approx(3 - ROOT)
    assert event(PAPER, "H").front_load == event(PAPER, "H").normal_load
    assert event(PAPER, "B").name == "full stick ends, forward slip starts"
    assert event(PAPER, "E").name == "forward slip ends, reverse slip starts"
    words_at_j = "the stick edge of forward slip passes a vertex of the memory curve"
    assert event(PAPER, "J").name == words_at_j
    assert "Q least" in event(PAPER, "A").name
    assert "P largest" in event(PAPER, "C").name


@pytest.mark.parametrize(
    ("phase", "first_letter", "range_of_q1"), [(60.0, "K", (1.2, 1.4)), (90.0, "L", (0.5, 0.7))]
)
def test_coinciding_events_are_found_by_each_of_their_letters(phase, first_letter, range_of_q1):
    """J at the largest P, or at the largest Q: one event. 3e-8 apart they are two, with a letter
    each.
    """

    def scene_of(q1):
        return make_scene(ellipse(3.0, 1.0, 0.0, q1, phase))

    def time_after(q1):
        scene = scene_of(q1)
        return event(scene, "J").time - event(scene, first_letter).time

    q1 = optimize.brentq(time_after, *range_of_q1, xtol=1e-14)
    scene = scene_of(q1)
    found = event(scene, first_letter)
    assert found.letter == first_letter + "J"
    assert event(scene, "J") == event(scene, found.letter) == found
    with pytest.raises(InputError, match="no event ''"):
        event(scene, "")
    slope = (time_after(q1 + 1e-4) - time_after(q1 - 1e-4)) / 2e-4
    nearly = scene_of(q1 + 3e-8 / slope)
    assert event(nearly, first_letter).letter == first_letter
    assert event(nearly, "J").letter == "J"


def test_lines_polygons_and_series_have_events_without_letters():
    series = make_scene(TimeSeriesLoad(rows=[[0.0, 0.0, 0.0], [1.0, 1.0, 0.2], [2.0, 0.5, -0.1]]))
    assert [event_in_order.time for event_in_order in events(series)] == [0.0, 1.0, 2.0]
    for scene in (
        load_scene("full-stick"),
        make_scene(polygon([(1.0, 0.0)], [(1.0, 0.4), (1.0, -0.4)])),
        series,
    ):
        assert all(event_in_order.letter == "" for event_in_order in events(scene))
        with pytest.raises(InputError, match="no event 'A'"):
            event(scene, "A")


# ------------------------------------------------------------------------ one path in several forms
def by_spans(scene, **options):
    """The answer by the engine of curved paths."""
    with pytest.MonkeyPatch.context() as patch:
        path = scene.load.path()
        friction = scene.friction.coefficient
        cycles = scene.cycles
        patch.setattr(
            answer_by_memory,
            "_path_of",
            lambda scene, time: history_of(path, friction, cycles, time),
        )
        return solve(scene, **options)


X = np.linspace(0, 2.3, 12)


# powers of the load that a field goes with
SIZES = {"dissipation": 2, "cycle_dissipation": 2, "dissipation_density": 1}


SHARES = st.lists(
    st.tuples(st.floats(0.05, 1), st.floats(-0.97, 0.97)), min_size=2, max_size=25, unique=True
)


@pytest.mark.parametrize("repeats", [False, True])
@given(shares=SHARES, flat=st.sampled_from([0.0, 0.5]))
@settings(max_examples=6)
def test_rows_as_a_series_are_rows_as_a_curved_path(repeats, shares, flat):
    """The lean way and the general one: every field, at rows and between them."""
    loads = [(p, 0.7 * p * use) for p, use in shares]
    by_rows, by_curve = both_ways(loads + loads[:1] * repeats, repeats, flat)
    top = max(p for p, _ in loads)
    for name in (*FIELDS[:3], "tangential_displacement", "normal_approach", *SIZES):
        close = 1e-11 * max(top, 1.0)
        if name in SIZES:
            close = 1e-11 * ((0.7 * top) ** 2 if SIZES[name] == 2 else top)
        np.testing.assert_allclose(
            getattr(by_rows, name), getattr(by_curve, name), rtol=1e-10, atol=close, err_msg=name
        )
    # c is the root of P_c: a last digit of P counts for 1e-8 there.
    np.testing.assert_allclose(
        *(np.nan_to_num(each.stick_half_width, nan=flat) for each in (by_rows, by_curve)), atol=1e-7
    )
    assert np.max(by_rows.record.certificates["tangential_balance"]) < 1e-13


def both_ways(loads, repeats, flat):
    """Rows at times 0, 1, ... as a series and by the engine of curved paths, at instants that are
    no rows; alike in when steady.
    """
    scene = make_scene(
        TimeSeriesLoad(rows=[[k, *load] for k, load in enumerate(loads)], repeats=repeats),
        0.7,
        flat,
    )
    # not at the middle of a step
    time = 0.37 + np.arange(0.0, len(loads) - 1 + 0.9 * repeats * len(loads) - 0.37, 0.37)
    by_rows, by_curve = (way(scene, x=X[:7], time=time) for way in (solve, by_spans))
    assert by_rows.steady_from == by_curve.steady_from
    return by_rows, by_curve


# -------------------------------------------------------------------------- long series, and effort


def test_a_long_series_answers_what_is_asked_and_nothing_else():
    """Counts of the work: no curve without a field, no quadrature without the dissipation, no field
    off the instants asked for.
    """
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
    np.testing.assert_allclose(
        np.sum(work.record.energy["dissipation"]), work.dissipation, rtol=1e-12
    )
    assert np.all(work.record.energy["dissipation"] >= 0)
    two = solve(scene, x=X, time=[600.5, 3.0], fields=("shear",))
    assert (two.work.counts["curves"], two.work.counts["slip_quadratures"]) == (2, 0)
    np.testing.assert_allclose(
        two.shear, by_spans(scene, x=X, time=[600.5, 3.0], fields=("shear",)).shear, atol=1e-13
    )
    at_all_times = solve(scene, x=X, time=bare.time, fields=("shear",))
    for name in ("normal_load", "tangential_load", "stick_half_width"):  # the state needs no curve
        np.testing.assert_allclose(
            getattr(bare, name), getattr(at_all_times, name), rtol=1e-12, atol=0
        )
    t = np.arange(2200.0)
    scene = make_scene(
        TimeSeriesLoad(rows=np.stack([t, 2 + np.cos(0.31 * t), 0.5 * np.sin(0.57 * t)], axis=1))
    )
    thinned = solve(scene, x=X[:2], fields=("pressure",))
    assert thinned.time[-1] == 2199
    assert any(f"{2201 - len(thinned.time)} were left out" in note for note in thinned.record.notes)


@pytest.mark.parametrize(
    "load",
    [
        {"kind": "time_series", "rows": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "repeats": False},
        {
            "kind": "polygon",
            "initial_loading": [(1, 0), (0, 0)],
            "cycle": [(0, 0)],
            "times": [0, 1, 2, 3, 4],
        },
    ],
    ids=["record", "cycle"],
)
def test_a_path_without_a_load_has_no_friction_work(load):
    """A share of the largest P was a division by 0."""
    answer = solve(load_scene("hertz-paper").vary(load=load))
    assert answer.dissipation == 0
    assert np.isnan(answer.loop_work)
    assert not np.any(answer.pressure[answer.normal_load == 0])
