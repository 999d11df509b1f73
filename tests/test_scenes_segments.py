"""Every kind of load segment answers alike: changes, rates, turning points and inverses of combinations of P and Q."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from scenes import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
    ChebyshevSegment,
    Combination,
    HarmonicSegment,
    StraightSegment,
    ellipse_segment,
    parabola_segment,
)

TURN = 2 * math.pi
ELLIPSE = ellipse_segment(4.0, 4.0 + TURN, (3.0, 1.1), (1.0, 0.7), 1.3)
SEGMENTS = {
    "straight": StraightSegment(1.0, 3.0, (2.0, -1.0), (2.5, 4.0)),
    "constant P": StraightSegment(-1.0, 3.0, (2.0, -1.0), (2.0, 0.5)),
    "parabola": parabola_segment(-1.0, 2.0, (3.0, 0.1), 0.25),
    "ellipse": ELLIPSE,
    "ellipse from elsewhere": HarmonicSegment(-3.0, 2.0, (3.0, 1.1), ((1.0, 2.5),), ((0.7, -1.0),)),
    "harmonics": HarmonicSegment(0.0, TURN, (3.0, 0.2), ((1.0, 0.2), (0.5, -0.7)), ((0.3, 1.4), (0.0, 0.0), (0.2, 0.1))),
    "many harmonics": HarmonicSegment(0.0, TURN, (3.0, 0.2), ((1.0, 0.2),), tuple((1 / k, 2.0 * k) for k in range(1, 41))),
    "series": ChebyshevSegment(0.5, 2.0, (3.0, 0.4, -0.3, 0.05, 0.1), (0.1, 0.5, 0.02, 0.3)),
}
EVERY = pytest.mark.parametrize("segment", SEGMENTS.values(), ids=SEGMENTS.keys())
COMBINATIONS = (NORMAL_LOAD, TANGENTIAL_LOAD, Combination(-0.6, 1.0), Combination(-0.6, -1.0))
WAVES = st.lists(st.tuples(st.just(0.0) | st.floats(1e-3, 1), st.floats(-180, 180)), min_size=1, max_size=3)


def runs(segment, what):
    """Stretches of time on which a combination does not turn."""
    marks = [segment.start, *segment.turning_points(what), segment.end]
    return list(pairwise(marks))


@EVERY
@pytest.mark.parametrize("what", COMBINATIONS)
def test_changes_and_rates_are_those_of_the_loads(segment, what):
    t = np.linspace(segment.start, segment.end, 41)
    p, q = segment.loads(t)
    value = what.normal * p + what.tangential * q
    np.testing.assert_allclose(segment.change_of(what, t[:, None], t), value[:, None] - value, atol=2e-14)
    p, q = segment.rates(t)
    np.testing.assert_allclose(segment.rate_of(what, t), what.normal * p + what.tangential * q, atol=3e-13)
    step = 1e-6
    ahead, behind = segment.change_of(what, t + step, t), segment.change_of(what, t - step, t)
    np.testing.assert_allclose(segment.rate_of(what, t), (ahead - behind) / (2 * step), atol=1e-8)


@EVERY
@pytest.mark.parametrize("what", COMBINATIONS)
def test_all_turning_points_are_found_and_nothing_else(segment, what):
    t = np.linspace(segment.start, segment.end, 19_997)
    rates = segment.rate_of(what, t)
    size = np.max(np.abs(rates))
    rates[np.abs(rates) < 1e-13 * max(size, 1.0)] = 0
    changes = np.flatnonzero(rates[:-1] * rates[1:] < 0)
    found = segment.turning_points(what)
    assert len(found) == len(changes) <= segment.most_turns
    for time, k in zip(found, changes, strict=True):
        assert t[k] - 1e-12 <= time <= t[k + 1] + 1e-12
        assert abs(segment.rate_of(what, time)) < 1e-12 * size


@EVERY
@pytest.mark.parametrize("what", COMBINATIONS)
def test_a_time_is_found_again_by_the_change_since_either_end(segment, what):
    for begin, end in runs(segment, what):
        t = np.linspace(begin, end, 33)
        for first, last in ((begin, end), (end, begin)):
            amount = segment.change_of(what, t, first)
            if abs(amount[0] - amount[-1]) < 1e-12:  # a constant load: any time will do
                continue
            again = segment.time_of(what, amount, first, last)
            np.testing.assert_allclose(segment.change_of(what, again, first), amount, atol=2e-15 * max(1.0, np.max(np.abs(amount))))
            most = amount[np.argmax(np.abs(amount))]
            beyond = segment.time_of(what, [-np.sign(most), 3 * most], first, last)
            assert beyond.tolist() == [first, last]


@settings(max_examples=15)
@example([(0.5, 0.0), (0.609375, -109.875), (0.34765625, 31.75)], [(1.0, -29.0)], -0.45)
@given(
    WAVES,
    WAVES,
    st.floats(-1, 1),
)
def test_times_on_harmonics_are_found_however_they_turn(normal, tangential, friction):
    """Newton's method once gave up after three bisections without gain: a time was 0.02 late."""
    waves = [tuple((size, math.radians(phase)) for size, phase in load) for load in (normal, tangential)]
    segment, what = HarmonicSegment(0.0, TURN, (3.0, 0.0), *waves), Combination(friction, 1.0)
    scale = sum(abs(friction) * size for size, _ in waves[0]) + sum(size for size, _ in waves[1])
    for begin, end in runs(segment, what):
        for first, last in ((begin, end), (end, begin)):
            for amount in segment.change_of(what, np.linspace(begin, end, 33), first).tolist():
                found = segment.change_of(what, segment.time_of(what, amount, first, last), first)
                assert abs(found - amount) <= 2e-14 * scale + 1e-290


def test_one_wave_keeps_its_digits_next_to_an_extremum():
    """There the sum of the changes of both loads has lost them."""
    what = Combination(-0.6, 1.0)
    top = ELLIPSE.turning_points(what)[0]
    apart = np.array([1e-3, 1e-5, 1e-7])
    expected = -ELLIPSE.wave(what)[0] * 2 * np.sin(apart / 2) ** 2 * np.sign(ELLIPSE.change_of(what, top, top + 1.0))
    np.testing.assert_allclose(ELLIPSE.change_of(what, top + apart, top), expected, rtol=1e-8)


def test_one_wave_has_a_mirrored_time():
    for what in COMBINATIONS:
        for time in (4.2, 6.0, 9.9):
            other = float(ELLIPSE.mirrored(what, time, 7.0))
            assert abs(other - 7.0) <= math.pi
            assert abs(ELLIPSE.change_of(what, other, time)) < 1e-14
    assert all(segment.mirrored(NORMAL_LOAD, 1.0, 1.0) is None for segment in SEGMENTS.values() if segment.ellipse is None)


def test_segments_state_what_they_are():
    assert {name for name, segment in SEGMENTS.items() if segment.is_straight} == {"straight", "constant P"}
    assert {name for name, segment in SEGMENTS.items() if segment.ellipse} == {"ellipse", "ellipse from elsewhere"}
    assert {name for name, segment in SEGMENTS.items() if segment.slope_and_bend(segment.end)} == {"straight", "parabola"}
    assert ChebyshevSegment(0.0, 1.0, (3.0, 1.0), (0.0, 2.0)).is_straight
    turned = SEGMENTS["ellipse from elsewhere"].ellipse
    assert (turned.phase, turned.origin) == (-3.5, 2.5)
    assert replace(ELLIPSE, normal=((1.0, 0.0), (0.0, 3.0))).ellipse == ELLIPSE.ellipse
    assert replace(ELLIPSE, normal=((1.0, 0.0), (1e-300, 0.0))).ellipse is None


@EVERY
def test_the_parabola_of_a_segment_is_its_path(segment):
    form = segment.slope_and_bend(segment.end)
    if form:
        times = np.linspace(segment.start, segment.end, 11)
        dp, dq = (segment.change_of(what, times, segment.end) for what in (NORMAL_LOAD, TANGENTIAL_LOAD))
        np.testing.assert_allclose(dq, (form[0] + form[1] * dp) * dp, atol=1e-14)


def test_a_load_that_starts_from_nothing_keeps_its_digits():
    parabola, step = SEGMENTS["parabola"], 2.0**-50 * np.arange(1.0, 9.0)
    p, q = parabola.loads(parabola.start + step)
    np.testing.assert_allclose(p, step, rtol=1e-14)  # 3 over a duration of 3
    np.testing.assert_allclose(q, (2 * 0.1 / 3 - 0.25) * step, rtol=1e-13)


@EVERY
@given(delay=st.floats(-50, 50))
def test_a_segment_does_the_same_later(segment, delay):
    t = np.linspace(segment.start, segment.end, 9)
    np.testing.assert_allclose(segment.shifted(delay).loads(t + delay), segment.loads(t), atol=2e-12)
    assert replace(ELLIPSE.shifted(7 * TURN), start=ELLIPSE.start, end=ELLIPSE.end) == ELLIPSE
