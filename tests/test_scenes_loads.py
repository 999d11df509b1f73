"""Loads: segments against their definition in 50 digits and against themselves; paths, bulk stress
and tilt; what is refused.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import semi_analytic
from refusals import refused_for, require_facts
from reports.checking import require_admissible
from scenes import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
    CallableLoad,
    ChebyshevSegment,
    Combination,
    EllipseLoad,
    HarmonicLoad,
    HarmonicSegment,
    InputError,
    LoadPath,
    PolygonLoad,
    Scene,
    StraightSegment,
    Tabulated,
    TimeSeriesLoad,
    ellipse_segment,
    load_scene,
    parabola_segment,
)
from scenes.errors import NotFoundError
from scenes.measured import rows_of_turning_points, rows_within_tolerance

TURN = 2 * math.pi
ELLIPSE = ellipse_segment(4.0, 4.0 + TURN, (3.0, 1.1), (1.0, 0.7), 1.3)
SEGMENTS = {
    "straight": StraightSegment(1.0, 3.0, (2.0, -1.0), (2.5, 4.0)),
    "constant P": StraightSegment(-1.0, 3.0, (2.0, -1.0), (2.0, 0.5)),
    "parabola": parabola_segment(-1.0, 2.0, (3.0, 0.1), 0.25),
    "ellipse": ELLIPSE,
    "ellipse from elsewhere": HarmonicSegment(-3.0, 2.0, (3.0, 1.1), ((1.0, 2.5),), ((0.7, -1.0),)),
    "harmonics": HarmonicSegment(
        0.0, TURN, (3.0, 0.2), ((1.0, 0.2), (0.5, -0.7)), ((0.3, 1.4), (0.0, 0.0), (0.2, 0.1))
    ),
    "many harmonics": HarmonicSegment(
        0.0, TURN, (3.0, 0.2), ((1.0, 0.2),), tuple((1 / k, 2.0 * k) for k in range(1, 41))
    ),
    "series": ChebyshevSegment(0.5, 2.0, (3.0, 0.4, -0.3, 0.05, 0.1), (0.1, 0.5, 0.02, 0.3)),
}
EVERY = pytest.mark.parametrize("segment", SEGMENTS.values(), ids=SEGMENTS)
COMBINATIONS = (NORMAL_LOAD, TANGENTIAL_LOAD, Combination(-0.6, 1.0))


# ----------------------------------------------------------------------------------------- segments
def exact_loads(segment, moment):
    """(P, Q) of a segment at a double in the working precision of mpmath, from the segment's
    definition.
    """
    t = mpmath.mpf(float(moment))
    start = mpmath.mpf(segment.start)
    end = mpmath.mpf(segment.end)
    match segment:
        case StraightSegment():
            part = (t - start) / (end - start)
            return tuple(
                a + (mpmath.mpf(b) - mpmath.mpf(a)) * part
                for a, b in zip(segment.first_point, segment.last_point, strict=True)
            )
        case ChebyshevSegment():
            u = 2 * (t - start) / (end - start) - 1

            def series(coefficients):
                return mpmath.fsum(c * mpmath.chebyt(k, u) for k, c in enumerate(coefficients))

            return series(segment.normal), series(segment.tangential)
        case HarmonicSegment():

            def wave(harmonics):
                terms = (a * mpmath.cos(k * t - b) for k, (a, b) in enumerate(harmonics, 1))
                return mpmath.fsum(terms)

            mean_normal, mean_tangential = segment.mean
            return mean_normal + wave(segment.normal), mean_tangential + wave(segment.tangential)


@EVERY
@settings(max_examples=15)
@given(part=st.floats(0, 1), step=st.floats(-14, -0.1), ahead=st.booleans())
def test_loads_are_the_definition_and_changes_free_of_cancellation(segment, part, step, ahead):
    """The relative error of a change stays at round-off however short the step is; a difference of
    loads has no digit at 1e-14.
    """
    since = segment.start + part * (segment.end - segment.start)
    moment = since + (1 if ahead else -1) * 10**step
    assume(segment.start <= moment <= segment.end and moment != since)
    changes = [
        float(segment.change_of(combination, moment, since))
        for combination in (NORMAL_LOAD, TANGENTIAL_LOAD)
    ]
    # 40 waves: a sum of as many rounded arguments
    is_long = len(getattr(segment, "tangential", ())) > 10
    with mpmath.workdps(50):
        before, after = (exact_loads(segment, t) for t in (since, moment))
        expected = [float(value) for value in before]
        np.testing.assert_allclose(
            segment.loads(since), expected, rtol=0, atol=2e-14 if is_long else 5e-15
        )
        # Arguments of sines are rounded, k t - b to a digit of its size: counted where a sine is
        # near its zero.
        waves = (
            [wave for part in (segment.normal, segment.tangential) for wave in enumerate(part, 1)]
            if is_long
            else []
        )
        rounded = 2.3e-16 * sum(k * abs(a) * (k * segment.end + abs(b)) for k, (a, b) in waves)
        slack = max(rounded, 4e-15) * abs(moment - since)
        for value, load_before, load_after in zip(changes, before, after, strict=True):
            assert (
                abs(value - (load_after - load_before))
                <= 1e-14 * abs(load_after - load_before) + slack
            )


def runs(segment, combination):
    """Stretches of time on which a combination does not turn."""
    return list(pairwise([segment.start, *segment.turning_points(combination), segment.end]))


@EVERY
def test_changes_and_rates_are_those_of_the_loads_in_any_shape_and_later_too(segment):
    t = np.linspace(segment.start, segment.end, 41)
    p, q = segment.loads(t)
    dp, dq = segment.rates(t)
    for combination in COMBINATIONS:
        value = combination.normal * p + combination.tangential * q
        np.testing.assert_allclose(
            segment.change_of(combination, t[:, None], t), value[:, None] - value, atol=2e-14
        )
        np.testing.assert_allclose(
            segment.rate_of(combination, t),
            combination.normal * dp + combination.tangential * dq,
            atol=3e-13,
        )
        ahead = segment.change_of(combination, t + 1e-6, t)
        behind = segment.change_of(combination, t - 1e-6, t)
        np.testing.assert_allclose(
            segment.rate_of(combination, t), (ahead - behind) / 2e-6, atol=1e-8
        )
    times = np.full((2, 3), t[10])
    assert {
        part.shape
        for part in (
            *segment.loads(times),
            *segment.rates(times),
            segment.change_of(combination, times, t[0]),
        )
    } == {(2, 3)}
    for delay in (-50.0, 0.3, 7 * TURN):
        np.testing.assert_allclose(
            segment.shifted(delay).loads(t + delay), segment.loads(t), atol=2e-12
        )
    for combination in COMBINATIONS:  # such as the moment of a line of action
        moment = segment.companion_of(combination)
        np.testing.assert_allclose(
            moment.loads(t),
            (0 * p, combination.normal * p + combination.tangential * q),
            rtol=0,
            atol=2e-14,
        )
        assert (moment.start, moment.end) == (segment.start, segment.end)
    if form := segment.slope_and_bend(segment.end):  # the parabola of a segment is its path
        since = [
            segment.change_of(load_kind, t, segment.end)
            for load_kind in (NORMAL_LOAD, TANGENTIAL_LOAD)
        ]
        np.testing.assert_allclose(since[1], (form[0] + form[1] * since[0]) * since[0], atol=1e-14)


@EVERY
@pytest.mark.parametrize("combination", COMBINATIONS)
def test_all_turning_points_are_found_and_nothing_else(segment, combination):
    t = np.linspace(segment.start, segment.end, 19_997)
    rates = segment.rate_of(combination, t)
    size = np.max(np.abs(rates))
    rates[np.abs(rates) < 1e-13 * max(size, 1.0)] = 0
    changes = np.flatnonzero(rates[:-1] * rates[1:] < 0)
    turns = segment.turning_points(combination)
    assert len(turns) == len(changes) <= segment.most_turning_points
    for moment, k in zip(turns, changes, strict=True):
        assert t[k] - 1e-12 <= moment <= t[k + 1] + 1e-12
        assert abs(segment.rate_of(combination, moment)) < 1e-12 * size


def found_again(segment, combination, close):
    """The change at the time that is found for an amount is that amount, from either end of every
    stretch.
    """
    for ends in runs(segment, combination):
        for first, last in (ends, ends[::-1]):
            amount = segment.change_of(combination, np.linspace(*ends, 33), first)
            if abs(amount[0] - amount[-1]) < 1e-12:  # a constant load: any time will do
                continue
            times = segment.time_of(combination, amount, first, last)
            np.testing.assert_allclose(
                segment.change_of(combination, times, first), amount, rtol=0, atol=close
            )
            most = amount[np.argmax(np.abs(amount))]
            assert segment.time_of(
                combination, [-np.sign(most), 3 * most], first, last
            ).tolist() == [
                first,
                last,
            ]


@EVERY
@pytest.mark.parametrize("combination", COMBINATIONS)
def test_a_time_is_found_again_by_the_change_since_either_end(segment, combination):
    size = max(
        np.max(np.abs(segment.change_of(combination, np.linspace(*ends, 33), ends[0])))
        for ends in runs(segment, combination)
    )
    found_again(segment, combination, 1e-14 * max(1.0, size))  # 6e-15 of 40 waves


def test_a_change_that_rounding_puts_beyond_an_end_is_at_that_end_and_no_number_is_nowhere():
    segment = SEGMENTS["series"]
    for begin, end in ((0.5, 2.0), (2.0, 0.5)):
        assert segment._time_inside(NORMAL_LOAD, np.array([9.0]), 9.0, begin, end).tolist() == [end]
    with pytest.raises(NotFoundError, match=r"changed as wanted, between 0\.5 and 2"):
        replace(segment, normal=(3.0, math.nan, 0.1)).time_of(NORMAL_LOAD, 0.1, 0.5, 2.0)


def test_one_wave_keeps_its_digits_next_to_an_extremum_and_has_a_mirrored_time():
    """There the sum of the changes of both loads has lost them."""
    combination = Combination(-0.6, 1.0)
    top = ELLIPSE.turning_points(combination)[0]
    distances = np.array([1e-3, 1e-5, 1e-7])
    expected = (
        -ELLIPSE.amplitude_and_lead(combination)[0]
        * 2
        * np.sin(distances / 2) ** 2
        * np.sign(ELLIPSE.change_of(combination, top, top + 1.0))
    )
    np.testing.assert_allclose(
        ELLIPSE.change_of(combination, top + distances, top), expected, rtol=1e-8
    )
    for combination in COMBINATIONS:
        for moment in (4.2, 6.0, 9.9):
            mirror_time = float(ELLIPSE.mirrored_time(combination, moment, 7.0))
            assert abs(mirror_time - 7.0) <= math.pi
            assert abs(ELLIPSE.change_of(combination, mirror_time, moment)) < 1e-14
    assert all(
        segment.mirrored_time(NORMAL_LOAD, 1.0, 1.0) is None
        for segment in SEGMENTS.values()
        if segment.ellipse is None
    )


# -------------------------------------------------------------------------------------------- paths
E = {
    "mean_normal_load": 3,
    "normal_amplitude": 1,
    "mean_tangential_load": 0.2,
    "tangential_amplitude": 1,
}
HARMONICS = HarmonicLoad(
    mean_normal_load=3.0,
    mean_tangential_load=0.2,
    normal_harmonics=[(1.0, 10.0), (0.5, -40.0)],
    tangential_harmonics=[(0.3, 80.0), (0.0, 0.0), (0.2, 5.0)],
)
FUNCTIONS = CallableLoad(
    normal_load=lambda t: 3 + math.cos(t) ** 3,
    tangential_load=lambda t: np.sin(np.sin(t)),
    duration=TURN,
    repeats=True,
)
PERIODIC = {
    "polygon": PolygonLoad(initial_loading=[(2, 0)], cycle=[(2, 1), (1, -1), (3, 0.5)]),
    "straight initial loading": EllipseLoad(**E),
    "parabola": EllipseLoad(**E, initial_loading="parabola"),
    "points on the way": EllipseLoad(**E, initial_loading=[(1, 0.5), (2, 0.1)]),
    "harmonics": HARMONICS,
    "functions": FUNCTIONS,
}


@pytest.mark.parametrize("load", PERIODIC.values(), ids=PERIODIC)
def test_a_path_starts_from_nothing_is_continuous_and_repeats(load):
    """`at` agrees with the segments at any revolution and keeps the shape of its times."""
    path = load.path()
    segments = list(path.segments(3))
    assert segments[0].start == path.start
    np.testing.assert_allclose(segments[0].loads(path.start), (0.0, 0.0), atol=1e-15)
    for before, after in pairwise(segments):
        assert after.start == pytest.approx(before.end, abs=1e-12)
        np.testing.assert_allclose(after.loads(after.start), before.loads(before.end), atol=1e-12)
    for segment in segments:
        times = np.linspace(segment.start, segment.end, 7)
        np.testing.assert_allclose(path.at(times), segment.loads(times), atol=1e-11)
    times = path.cycle_start + path.period * np.linspace(0, 1, 23)
    for turns in (1, 17, 40):
        np.testing.assert_allclose(path.at(times + turns * path.period), path.at(times), atol=1e-11)
    assert [
        v.shape for shape in ((), (2, 3)) for v in path.at(np.full(shape, path.cycle_start))
    ] == [(), (), (2, 3), (2, 3)]


def test_the_phase_of_an_ellipse_in_radians_has_a_name_that_says_so():
    load = EllipseLoad(mean_normal_load=3, phase_degrees=60)
    assert load.phase_radians == math.radians(60)
    with pytest.warns(DeprecationWarning, match="phase_radians"):
        assert load.phase == load.phase_radians


def test_ways_to_the_cycle():
    """The paper's parabola ends tangent to the ellipse: dQ/dP = 0 where |Q - Q0| is largest. Points
    are passed in equal times.
    """
    path = PERIODIC["parabola"].path()
    for segment, moment in (
        (path.initial_loading[0], path.cycle_start),
        (path.cycle[0], path.cycle_start),
    ):
        dp, dq = segment.rates(moment)
        assert float(dq / dp) == pytest.approx(0.0, abs=1e-15)
    path = PERIODIC["points on the way"].path()
    assert [segment.last_point for segment in path.initial_loading[:2]] == [(1, 0.5), (2, 0.1)]
    assert [segment.end - segment.start for segment in path.initial_loading] == pytest.approx(
        [math.pi] * 3
    )
    assert len(FUNCTIONS.path().initial_loading) == 1
    once = CallableLoad(
        normal_load=lambda t: t, tangential_load=lambda t: 0.1 * t**2, duration=2.0
    ).path()
    assert (once.start, once.period) == (0.0, None)  # unloaded at its start
    bent = CallableLoad(
        normal_load=lambda t: 2 + t,
        tangential_load=lambda t: 0 * t,
        duration=2.0,
        initial_loading=[(1.0, 0.3)],
    )
    assert [float(v) for v in bent.path().at(-1.0)] == pytest.approx([1.0, 0.3])


def test_a_path_that_just_ends():
    path = PolygonLoad(initial_loading=[(2, 0), (2, 1)]).path()
    assert (path.period, path.cycle) == (None, ())
    assert [segment.last_point for segment in path.segments(5)] == [(2, 0), (2, 1)]
    assert [float(v) for v in path.at(2.0)] == [2.0, 1.0]
    with pytest.raises(ValueError, match=r"runs from 0\.0 to 2\.0"):
        path.at(2.1)
    with pytest.raises(ValueError, match="outside the load path"):
        path.at([-0.1, 0.5])


# ---------------------------------------------------------------------------------------- harmonics


# ---------------------------------------------------------------------------- functions and records
def test_functions_are_followed_to_round_off_and_a_kink_becomes_an_edge():
    path = FUNCTIONS.path()
    t = np.linspace(0, TURN, 501)
    np.testing.assert_allclose(path.at(t), (3 + np.cos(t) ** 3, np.sin(np.sin(t))), atol=1e-13)
    assert all(isinstance(segment, ChebyshevSegment) for segment in path.cycle)
    kinked = CallableLoad(
        normal_load=lambda t: 2 + 0 * t, tangential_load=lambda t: np.abs(t - 1 / 3), duration=1.0
    )
    ends = [segment.end for segment in kinked.path().initial_loading]
    assert min(abs(end - 1 / 3) for end in ends) < 1e-12
    assert len(ends) < 12


RECORD = {"rows": [[0, 1, 0], [1, 2, 0.1], [2, 1, 0]], "repeats": False}


def make(keys):
    if "rows" in keys:
        return TimeSeriesLoad(**{"repeats": True} | keys)
    return CallableLoad(
        **{"normal_load": lambda t: 2 + 0 * t, "tangential_load": lambda t: 0 * t, "duration": 1.0}
        | keys
    )


REFUSED_LOADS = [
    ({"tangential_load": lambda t: np.sign(t - 0.5)}, "tangential_load"),
    ({"normal_load": lambda t: 1 / (t - 0.5 + 0j).real}, "normal_load is not finite at time 0.5"),
    (
        {"tangential_load": lambda t: t, "repeats": True},
        "tangential_load jumps from 1 to .* at time 1",
    ),
    ({"normal_load": 3.0}, "only be built in Python"),
    ({"duration": 0.0}, "greater than 0"),
    ({"rows": [[0, 1, 0], [1, 2, 0]]}, "must end with the loads of its first row"),
    ({"rows": [[0, 0, 0], [1, 2, 0], [2, 0, 0]]}, "can't start unloaded"),
    (
        {"rows": [[0, 1, math.nan], [1, 1, 0]]},
        r"row 1: \[0\.0, 1\.0, nan\] is not all finite numbers",
    ),
    ({"rows": [[0, 1], [1, 1]]}, "three numbers"),
    *(
        (RECORD | keys, why)
        for keys, why in (
            ({"threshold": {"P": 1}}, "threshold has a use with reduce"),
            ({"reduce": "tolerance"}, "needs a threshold, such as"),
            ({"reduce": "tolerance", "threshold": {}}, "needs a threshold, such as"),
            ({"reduce": "turning_points", "threshold": {"P": -1}}, "greater than or equal to 0"),
            ({"average": 2, "repeats": True}, "average goes with records that do not repeat"),
            ({"average": 2}, "average = 2 leaves one of 3 rows"),
            ({"average": 0}, "greater than or equal to 1"),
        )
    ),
]


@pytest.mark.parametrize(("keys", "why"), REFUSED_LOADS)
def test_functions_and_rows_that_will_not_do_are_refused(keys, why):
    with np.errstate(all="ignore"), pytest.raises(InputError, match=why):
        make(keys)


# ---------------------------------------------------------------------------------------- reduction
SWINGS = st.lists(st.integers(-6, 6), min_size=2, max_size=40)


@settings(max_examples=100)
@given(values=SWINGS, threshold=st.sampled_from([0.0, 0.5, 1.0, 2.0, 5.0]))
@example([0, 0, 3, 3, 1, 1, 4], 0.0)
def test_turning_points_are_those_of_the_definition(values: list[int], threshold: float) -> None:
    """They turn by more than the threshold each, and between two of them nothing turns back by
    more.
    """
    array = np.array(values, dtype=float)
    turns = rows_of_turning_points(array, threshold)
    ends = np.unique([0, *turns, len(values) - 1])
    inner = array[turns[turns > 0]] if len(turns) else array[:0]
    assert np.all(np.diff(turns) > 0)
    assert np.all(np.abs(np.diff(inner)) > threshold)
    assert np.all(np.diff(inner)[:-1] * np.diff(inner)[1:] < 0)
    for first, last in pairwise(ends.tolist()):
        swing = array[first : last + 1] * (1 if array[last] >= array[first] else -1)
        back = float(np.max(np.maximum.accumulate(swing) - swing))
        open_end = last == len(values) - 1  # the last swing has not left its extreme by more yet
        assert back <= threshold or (open_end and array[last] == array[first])
    if threshold == 0:
        steps = [step for step in np.diff(array) if step]
        assert len(turns[turns > 0]) == sum(
            step_before * step_after < 0 for step_before, step_after in pairwise(steps)
        )


def distance_in_order(path: np.ndarray, vertices: np.ndarray) -> float:
    """By brute force: the least size at which a walk along the kept lines, never back, is that near
    each point of the path.
    """
    worst = 0.0
    for first, last in pairwise(vertices.tolist()):
        share = np.linspace(0, 1, 2001)
        line = path[first] + share[:, None] * (path[last] - path[first])
        reached = np.zeros(1)
        # the best walk to each place on the line: minimax over what came before
        for point in path[first + 1 : last]:
            near = np.max(np.abs(line - point), axis=1)
            reached = np.maximum(near, np.minimum.accumulate(np.broadcast_to(reached, near.shape)))
        worst = max(worst, float(np.min(reached)))
    return worst


@settings(max_examples=60)
@given(
    points=st.lists(st.tuples(st.integers(-5, 5), st.integers(-5, 5)), min_size=2, max_size=25),
    size=st.sampled_from([0.5, 1, 2, 4]),
)
@example([(0, 0), (1, 0), (5, 0), (1, 0), (5, 0)], 1)  # near the whole line, and to and fro on it
@example([(0, 0), (4, 0), (0, 0), (4, 0)], 1)  # a distance without order misses that
def test_a_reduced_path_stays_within_its_tolerance_in_order(
    points: list[tuple[int, int]], size: float
) -> None:
    path = np.array(points, dtype=float)
    vertices = rows_within_tolerance(path, np.array([size, size]))
    assert (vertices[0], vertices[-1]) == (0, len(path) - 1)
    assert np.all(np.diff(vertices) > 0)
    assert (
        distance_in_order(path, vertices) <= size + 0.01
    )  # of the samples on a line of at most 10
    scaled = rows_within_tolerance(
        path * [1, 0.25], np.array([size, size / 4])
    )  # each load has its own tolerance
    assert scaled.tolist() == vertices.tolist()


def test_a_reduced_record_keeps_the_work_and_says_what_it_kept() -> None:
    time = np.linspace(0, 6, 1200)
    rows = np.column_stack(
        [time, 90 + 8 * np.sin(2 * np.pi * time + 0.4), 20 * np.sin(2 * np.pi * time)]
    )
    base = load_scene("hertz-paper").vary(friction=0.6, load=TimeSeriesLoad(rows=rows.tolist()))

    def work(**keys: object) -> tuple[float, int]:
        scene = base.vary(load=keys)
        ends = scene.load.series()[[0, -1], 0]
        return semi_analytic.solve(
            scene, x=[0.0], time=ends, fields=("dissipation",)
        ).dissipation, len(scene.load.kept_rows())

    full_work, _ = work()
    for keys, most, most_rows in (
        ({"reduce": "tolerance", "threshold": {"P": 0.02, "Q": 0.02}}, 2e-3, 350),
        ({"reduce": "tolerance", "threshold": {"P": 0.2, "Q": 0.2}}, 2e-2, 120),
        ({"reduce": "turning_points"}, 0.2, 30),
        ({"average": 4}, 1e-2, 300),
    ):
        reduced_work, count = work(**keys)
        assert abs(reduced_work / full_work - 1) < most, keys
        assert count <= most_rows, keys
    reduced_load = base.vary(load={"reduce": "turning_points", "threshold": {"Q": 0.5}}).load
    require_facts(
        reduced_load.in_words("N/mm"), "1200 rows", "turning points", "0 in P or 0.5 in Q"
    )
    assert base.vary(load={"average": 4}).load.rows == base.load.rows  # all rows stay in the scene


# ----------------------------------------------------------------------------- bulk stress and tilt
PAPER = {
    "mean_normal_load": 3,
    "normal_amplitude": 1,
    "mean_tangential_load": 1.1,
    "tangential_amplitude": 1,
}
OF_WAVES: dict[str, Any] = {
    "mean_normal_load": 3,
    "normal_harmonics": [(1, 0), (0.2, 30)],
    "mean_tangential_load": 0.1,
    "tangential_harmonics": [(1, 90), (0.3, 0)],
}
CORNERS: dict[str, Any] = {"initial_loading": [(2, 0), (3, 0.3)], "cycle": [(3, 1.8), (2.5, -1.8)]}
ROWS = [[0, 2, 0.2], [1, 2, 1], [3, 1, 0], [4, 2, 0.2]]
OF_FUNCTIONS: dict[str, Any] = {
    "normal_load": lambda t: 3 + math.cos(t),
    "tangential_load": math.sin,
    "duration": 2 * math.pi,
}
Q_OF_WAVES = {"mean": 0.05, "harmonics": [(0.5, 90), (0.15, 0)], "initial_loading": [0.05]}
# Loads whose stress below is half of Q, whose stress above is twice P, whose tilt is 0.1 P, stated
# in each kind's own way.
STATED = {
    "ellipse": EllipseLoad(
        **PAPER,
        bulk_stress_lower={"mean": 0.55, "amplitude": 0.5, "phase_degrees": 90},
        bulk_stress_upper={"mean": 6, "amplitude": 2},
        tilt={"mean": 0.3, "amplitude": 0.1},
    ),
    "harmonics": HarmonicLoad(
        **OF_WAVES,
        initial_loading=[(1, 0.1)],
        bulk_stress_lower=Q_OF_WAVES,
        bulk_stress_upper={"mean": 6, "harmonics": [(2, 0), (0.4, 30)]},
        tilt={"mean": 0.3, "harmonics": [(0.1, 0), (0.02, 30)]},
    ),
    "polygon": PolygonLoad(
        **CORNERS,
        bulk_stress_lower=(0, 0.15, 0.9, -0.9),
        bulk_stress_upper=(4, 6, 6, 5),
        tilt=(0.2, 0.3, 0.3, 0.25),
    ),
    "rows": TimeSeriesLoad(
        rows=ROWS,
        repeats=True,
        bulk_stress_lower=(0.1, 0.5, 0, 0.1),
        bulk_stress_upper=(4, 4, 2, 4),
        tilt=(0.2, 0.2, 0.1, 0.2),
    ),
    "functions": CallableLoad(
        **OF_FUNCTIONS,
        repeats=True,
        bulk_stress_lower=lambda t: math.sin(t) / 2,
        bulk_stress_upper=lambda t: 6 + 2 * math.cos(t),
        tilt=lambda t: 0.3 + 0.1 * math.cos(t),
    ),
}


@pytest.mark.parametrize("kind", STATED)
def test_stresses_and_tilt_follow_the_loads_in_every_cycle(kind: str) -> None:
    """P and Q are those of the load without them."""
    plain = STATED[kind].vary(bulk_stress_lower=None, bulk_stress_upper=None, tilt=None).path()
    path = STATED[kind].path()
    assert (path.has_bulk_or_tilt, path.moment_is_given, plain.has_bulk_or_tilt) == (
        True,
        False,
        False,
    )
    for leg, bare in zip(path.segments(3), plain.segments(3), strict=True):
        time = np.linspace(leg.start, leg.end, 7)
        assert leg.bulk is not None
        assert leg.tilt_and_moment is not None
        assert (leg.bulk.start, leg.bulk.end) == (leg.start, leg.end)
        p, q = leg.loads(time)
        assert np.array_equal((p, q), bare.loads(time))
        assert bare.bulk is bare.tilt_and_moment is None
        np.testing.assert_allclose(leg.bulk.loads(time), (q / 2, 2 * p), rtol=0, atol=3e-14)
        np.testing.assert_allclose(
            leg.tilt_and_moment.loads(time), (0.1 * p, 0 * p), rtol=0, atol=3e-15
        )
        np.testing.assert_allclose(
            leg.bulk.rates(time),
            (leg.rates(time)[1] / 2, 2 * leg.rates(time)[0]),
            rtol=0,
            atol=3e-11,
        )


NUMBERS = {
    "ellipse": PAPER,
    "harmonics": OF_WAVES,
    "polygon": CORNERS,
    "functions": OF_FUNCTIONS | {"repeats": True},
}


@pytest.mark.parametrize("kind", NUMBERS)
def test_a_number_grows_with_p_then_stays_and_a_line_of_action_makes_the_moment(kind: str) -> None:
    load = type(STATED[kind])(
        **NUMBERS[kind], bulk_stress_upper=50.0, line_of_action={"x": 0.2, "height": 3.0}
    )
    path: LoadPath = load.path()
    assert path.moment_is_given
    end = float(path.initial_loading[-1].loads(path.cycle_start)[0])
    for leg in path.segments(2):
        assert leg.bulk is not None
        assert leg.tilt_and_moment is not None
        time = np.linspace(leg.start, leg.end, 5)
        p, q = leg.loads(time)
        stress = 50 * p / end if leg.end <= path.cycle_start else np.full(5, 50.0)
        np.testing.assert_allclose(leg.bulk.loads(time), (0 * p, stress), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(
            leg.tilt_and_moment.loads(time), (0 * p, 0.2 * p + 3 * q), rtol=1e-12, atol=1e-12
        )


REFUSED = {
    "two ways to turn": (
        {"tilt": 0.1, "moment": 2.0},
        "tilt and moment say the same thing: state one of them",
    ),
    "a list too short": (
        {"bulk_stress_lower": (1.0, 2.0)},
        "has 2 values, and 4 are needed, one for each point",
    ),
    "a word": ({"bulk_stress_lower": "much"}, "should be a valid number"),
    "not finite": ({"tilt": math.inf}, "should be a finite number"),
    "a wave beside a polygon": ({"tilt": {"amplitude": 1.0}}, "tilt"),
    "a key of no line": ({"line_of_action": {"y": 1.0}}, "unknown key line_of_action.y = 1.0"),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_what_cannot_be_meant_is_refused(fault: str) -> None:
    changes, words = REFUSED[fault]
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        PolygonLoad(**CORNERS).vary(**changes)


def test_columns_of_a_record_are_read_where_they_are_named(tmp_path: Path) -> None:
    text = load_scene("time-series").model_dump_json(exclude_none=True)
    assert "bulk" not in text
    table = "time,P,Q,S [ksi],A [deg]\n0,2,0,1,0\n1,2,1,2,3\n3,2,0,1,0\n"
    (tmp_path / "rows.csv").write_text(table, encoding="utf-8")
    (tmp_path / "mine.toml").write_text(
        'material = {young_modulus = 1000.0, poisson_ratio = 0.3}\nprofile = {kind = "hertz",'
        ' radius = 10.0}\nfriction = 0.8\n[load]\nkind = "time_series"\nfile = "rows.csv"\nrepeats'
        ' = true\ncolumns = {bulk_stress_lower = "S", tilt = "A"}\n',
        encoding="utf-8",
    )
    load = load_scene(tmp_path / "mine.toml").load
    assert isinstance(load, TimeSeriesLoad)
    np.testing.assert_allclose(
        load.bulk_stress_lower, [6.894757293, 13.789514586, 6.894757293], rtol=1e-9
    )
    np.testing.assert_allclose(load.tilt, np.radians([0, 3, 0]))
    assert load.rows.values.shape == (3, 3)
    assert (
        dict(load.read_as or ())["bulk_stress_lower"]
        == "'S [ksi]', ksi (in its heading), times 6.89475729"
    )
    load_scene(tmp_path / "mine.toml").save(tmp_path / "copy.toml")
    copy = load_scene(tmp_path / "copy.toml").load
    assert isinstance(copy, TimeSeriesLoad)
    assert copy.bulk_stress_lower == load.bulk_stress_lower
    # Other rows have no such columns; a reduced record would lose theirs.
    assert load.vary(rows=ROWS).bulk_stress_lower is None
    with pytest.raises(InputError, match="average and reduce go with records of P and Q alone"):
        load.vary(reduce="turning_points")
    (tmp_path / "mine.toml").write_text(
        (tmp_path / "mine.toml").read_text().replace('"rows.csv"', '"rows.csv"\ntilt = 0.1')
    )
    with refused_for("mine.toml", "tilt is a column of the file"):
        load_scene(tmp_path / "mine.toml")


def test_a_table_keeps_its_two_sides() -> None:
    x = np.linspace(-1.0, 2.0, 31)
    rows = np.stack([x, np.where(x < 0, 2.0, 0.5) * x**2], axis=1)
    with pytest.raises(ValueError, match="has no partner on the other side"):
        Tabulated(points=rows)
    profile = Tabulated(points=rows, symmetric=False)
    assert not profile.symmetric
    at = np.array([-0.85, -0.3, 0.0, 0.3, 1.95])
    np.testing.assert_allclose(profile.height(at), np.where(at < 0, 2.0, 0.5) * at**2, atol=1e-12)
    with pytest.raises(InputError, match="take `sides`"):
        profile.spline()
    mirrored = Tabulated(points=(rows * [-1.0, 1.0])[::-1], symmetric=False)
    assert np.array_equal(mirrored.height(-at), profile.height(at))
    rows[3, 1] = 9.0
    with pytest.raises(ValueError, match="row 3: left side, x counted to the left"):
        Tabulated(points=rows, symmetric=False)


# -------------------------------------------------------------------- a record that begins in noise
def noisy_record(seed=0):
    """Noise about P = 0 for ten rows, loading to P = 100, then Q to and fro at constant P; noise of
    0.3 in both loads.
    """
    random = np.random.default_rng(seed)
    normal = np.concatenate([np.zeros(10), np.linspace(2.0, 100.0, 20), np.full(30, 100.0)])
    tangential = np.concatenate([np.zeros(30), 30 * np.sin(np.linspace(0.0, 6.0, 30))])
    noise = 0.3 * random.standard_normal((2, 60))
    return np.column_stack([0.1 * np.arange(60), normal + noise[0], tangential + noise[1]])


def record_scene(**keys):
    return load_scene("hertz-paper").vary(
        load={"kind": "time_series", "rows": noisy_record()} | keys, friction=0.6, expected=()
    )


def test_noise_below_a_stated_load_is_initial_loading_at_q_0_and_the_rest_is_as_it_stands():
    rows = noisy_record()
    with pytest.raises(
        InputError, match=r"that is row \d+ of 60\. .* write load\.least_normal_load = \d"
    ) as refused:
        require_admissible(record_scene(), "mine.toml")
    stated = float(str(refused.value).rpartition("= ")[2])
    scene = record_scene(least_normal_load=stated)
    require_admissible(scene, "mine.toml")
    path = scene.load.series()
    first = int(np.argmax(rows[:, 1] >= stated))
    np.testing.assert_array_equal(path[0, 1:], [0.0, 0.0])
    np.testing.assert_array_equal(path[1], [rows[first - 1, 0], stated, 0.0])
    np.testing.assert_array_equal(path[2:], rows[first:])
    # W is that of the rows from there on, which begin by a straight line to the first of them: the
    # same but for noise.
    cut = record_scene(start={"row": first + 1})
    work, work_of_cut = (
        semi_analytic.solve(each, x=0.0, fields="dissipation").dissipation for each in (scene, cut)
    )
    assert work == pytest.approx(work_of_cut, rel=1e-3)


def test_start_and_end_cut_a_record_by_time_and_by_row():
    rows = noisy_record()
    for keys in (
        {"start": 1.95, "end": 4.0},
        {"start": {"row": 21}, "end": {"row": 41}},
        {"start": rows[20, 0], "end": {"row": 41}},
    ):
        np.testing.assert_array_equal(record_scene(**keys).load.used_rows().values, rows[20:41])
    bulk = {"bulk_stress_lower": np.arange(60.0).tolist(), "start": {"row": 31}}
    path = record_scene(**bulk).load.path()
    legs = (*path.initial_loading, *path.cycle)
    np.testing.assert_allclose(
        [float(leg.bulk.loads(leg.end)[0]) for leg in legs], np.arange(30.0, 60.0)
    )
    assert float(legs[0].bulk.loads(legs[0].start)[0]) == 0
    means = record_scene(start={"row": 31}, average=3)
    assert len(means.load.kept_rows()) == 10
    assert "30 of the 60 rows" in means.load.in_words("N/mm")
    json_again = Scene.model_validate_json(means.model_dump_json())
    assert json_again.load == means.load


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"start": {"row": 60}}, "row 60: start and end leave 1 rows"),
        ({"start": 99.0}, "start and end leave 0 rows"),
        ({"least_normal_load": 200.0}, "no row reaches least_normal_load = 200: P is 10"),
        (
            {"least_normal_load": 2.0, "tilt": 1e-4},
            "least_normal_load goes with records of P and Q alone",
        ),
        ({"start": {"row": 0}}, "row"),
    ],
)
def test_a_cut_that_leaves_no_record_is_one_sentence(keys, sentence):
    with pytest.raises(InputError, match=sentence):
        record_scene(**keys)
