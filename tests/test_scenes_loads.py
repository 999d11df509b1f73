"""Load paths: segments against 50-digit arithmetic, the path as a whole, profiles."""

import itertools
import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from scenes import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
    ChebyshevSegment,
    EllipseLoad,
    FlatRounded,
    HarmonicSegment,
    Hertz,
    PolygonLoad,
    StraightSegment,
    ellipse_segment,
    parabola_segment,
)

STRAIGHT = StraightSegment(1.0, 3.0, (2.0, -1.0), (2.5, 4.0))
PARABOLA = parabola_segment(-1.0, 2.0, (3.0, 0.1), 0.25)
ELLIPSE = ellipse_segment(4.0, 4.0 + 2 * math.pi, (3.0, 1.1), (1.0, 0.7), 1.3)
HARMONICS = HarmonicSegment(0.0, 6.0, (3.0, 0.2), ((1.0, 0.2), (0.5, -0.7)), ((0.3, 1.4), (0.0, 0.0), (0.2, 0.1)))
SERIES = ChebyshevSegment(0.5, 2.0, (3.0, 0.4, -0.3, 0.05, 0.1), (0.1, 0.5, 0.02, 0.3))
LEGS = {"straight": STRAIGHT, "parabola": PARABOLA, "ellipse": ELLIPSE, "harmonics": HARMONICS, "series": SERIES}
EVERY_LEG = pytest.mark.parametrize("leg", LEGS.values(), ids=LEGS.keys())

inside = st.floats(0, 1)


def exact_loads(leg, time):
    """(P, Q) of a leg at a double `time` in the working precision of mpmath, from the leg's definition."""
    t, start, end = mpmath.mpf(float(time)), mpmath.mpf(leg.start), mpmath.mpf(leg.end)
    match leg:
        case StraightSegment():
            part = (t - start) / (end - start)
            return tuple(a + (mpmath.mpf(b) - mpmath.mpf(a)) * part for a, b in zip(leg.first, leg.last, strict=True))
        case ChebyshevSegment():
            u = 2 * (t - start) / (end - start) - 1
            series = (leg.normal, leg.tangential)
            return tuple(mpmath.fsum(c * mpmath.chebyt(k, u) for k, c in enumerate(part)) for part in series)
        case HarmonicSegment():
            loads = zip(leg.mean, (leg.normal, leg.tangential), strict=True)
            return tuple(m + mpmath.fsum(a * mpmath.cos(k * t - b) for k, (a, b) in enumerate(w, 1)) for m, w in loads)


def at_part(leg, part):
    return leg.start + part * (leg.end - leg.start)


@EVERY_LEG
@given(part=inside)
def test_loads_are_the_definition(leg, part):
    time = at_part(leg, part)
    with mpmath.workdps(50):
        exact = [float(value) for value in exact_loads(leg, time)]
    np.testing.assert_allclose([float(v) for v in leg.loads(time)], exact, rtol=0, atol=5e-15)


@EVERY_LEG
@given(part=inside, step=st.floats(-14, -0.1), ahead=st.booleans())
def test_change_is_free_of_cancellation(leg, part, step, ahead):
    """The relative error stays at rounding however small the step is; a difference of loads has none left at 1e-14."""
    since = at_part(leg, part)
    time = since + (1 if ahead else -1) * 10**step
    assume(leg.start <= time <= leg.end and time != since)
    found = [float(leg.change_of(what, time, since)) for what in (NORMAL_LOAD, TANGENTIAL_LOAD)]
    with mpmath.workdps(50):
        exact = [b - a for a, b in zip(exact_loads(leg, since), exact_loads(leg, time), strict=True)]
        # 4e-15 of the sines' arguments, which are rounded: counted where a sine is near its zero.
        slack = [4e-15 * abs(time - since)] * 2
        for value, true, extra in zip(found, exact, slack, strict=True):
            assert abs(value - true) <= 1e-14 * abs(true) + extra


def test_plain_difference_would_fail_that_test():
    since = at_part(ELLIPSE, 0.3)
    time = since + 1e-12
    plain = float(ELLIPSE.loads(time)[0] - ELLIPSE.loads(since)[0])
    with mpmath.workdps(50):
        exact = exact_loads(ELLIPSE, time)[0] - exact_loads(ELLIPSE, since)[0]
        assert abs(plain - exact) > 1e-6 * abs(exact)
        assert abs(float(ELLIPSE.change_of(NORMAL_LOAD, time, since)) - exact) < 1e-14 * abs(exact)


@EVERY_LEG
def test_any_shape_goes_in_and_comes_out(leg):
    times = np.full((2, 3), at_part(leg, 0.25))
    for found in (
        leg.loads(times),
        leg.rates(times),
        [leg.change_of(what, times, leg.start) for what in (NORMAL_LOAD, TANGENTIAL_LOAD)],
    ):
        assert [part.shape for part in found] == [(2, 3), (2, 3)]


def test_straight_leg_meets_both_ends_to_the_last_digit():
    leg = StraightSegment(0.1, 0.7, (0.1, 0.3), (1.1, -0.7))
    assert [float(v) for v in leg.loads(0.1)] == [0.1, 0.3]
    assert [float(v) for v in leg.loads(0.7)] == [1.1, -0.7]


def test_parabola_is_tangent_to_the_ellipse_at_its_end():
    """The paper's initial loading: through the origin, and dQ/dP at its end is that of the ellipse where |Q - Q0| is largest: 0."""
    load = EllipseLoad(
        mean_normal_load=3, normal_amplitude=1, mean_tangential_load=1.1, tangential_amplitude=1, initial_loading="parabola"
    )
    path = load.path()
    (parabola,), (turn,) = path.initial_loading, path.cycle
    assert parabola.slope_and_bend(parabola.end)[0] == 0
    assert [float(v) for v in parabola.loads(parabola.start)] == [0.0, 0.0]
    np.testing.assert_allclose(parabola.loads(parabola.end), turn.loads(turn.start), rtol=1e-15, atol=1e-15)
    dp, dq = parabola.rates(parabola.end)
    along, across = turn.rates(turn.start)
    assert float(dq / dp) == pytest.approx(0.0, abs=1e-15)
    assert float(across / along) == pytest.approx(0.0, abs=1e-15)


@given(slope=st.floats(-2, 2), p=st.floats(0.1, 10), q=st.floats(-5, 5))
def test_parabola_ends_with_the_slope_asked_for(slope, p, q):
    leg = parabola_segment(0.0, 2.0, (p, q), slope)
    dp, dq = leg.rates(2.0)
    assert float(dq / dp) == pytest.approx(slope, abs=1e-12 * (1 + abs(q) / p))
    assert [float(v) for v in leg.loads(2.0)] == pytest.approx([p, q], abs=1e-12)


@given(phase=st.floats(-180, 180))
@example(0.0)
@example(180.0)
@example(-180.0)
def test_cycle_starts_where_q_is_farthest_from_its_mean_while_p_grows(phase):
    load = EllipseLoad(
        mean_normal_load=3, normal_amplitude=1, mean_tangential_load=0.2, tangential_amplitude=1, phase_degrees=phase
    )
    path = load.path()
    p_rate, q_rate = (float(v) for v in path.cycle[0].rates(path.cycle_start))
    assert abs(q_rate) < 1e-12
    assert p_rate > -1e-12
    assert path.period == pytest.approx(2 * math.pi, rel=1e-15)
    np.testing.assert_allclose(path.at(path.start), (0.0, 0.0), atol=1e-15)


@given(phase=st.floats(0.5, 179.5))
def test_negative_phase_is_the_mirrored_history(phase):
    """Q at -phase, mirrored, passes the same points of the P-Q plane in the same order."""
    make = {"mean_normal_load": 3, "normal_amplitude": 1, "tangential_amplitude": 0.5}
    there = EllipseLoad(**make, phase_degrees=phase, mean_tangential_load=0.2).path()
    mirrored = EllipseLoad(**make, phase_degrees=phase - 180, mean_tangential_load=-0.2).path()
    along = np.linspace(0, 2 * math.pi, 9)
    p, q = there.at(there.cycle_start + along)
    p_mirrored, q_mirrored = mirrored.at(mirrored.cycle_start + along)
    np.testing.assert_allclose(p_mirrored, p, atol=1e-14)
    np.testing.assert_allclose(q_mirrored, -q, atol=1e-14)


def periodic_loads():
    corners = PolygonLoad(initial_loading=[(2, 0)], cycle=[(2, 1), (1, -1), (3, 0.5)])
    ellipse = {"mean_normal_load": 3, "normal_amplitude": 1, "mean_tangential_load": 0.2, "tangential_amplitude": 1}
    return {
        "polygon": corners,
        "straight initial loading": EllipseLoad(**ellipse),
        "parabola": EllipseLoad(**ellipse, initial_loading="parabola"),
        "points on the way": EllipseLoad(**ellipse, initial_loading=[(1, 0.5), (2, 0.1)]),
    }


@pytest.mark.parametrize("load", periodic_loads().values(), ids=periodic_loads().keys())
@given(part=st.floats(0, 1), turns=st.integers(1, 40))
def test_path_is_periodic_and_continuous(load, part, turns):
    path = load.path()
    time = path.cycle_start + part * path.period
    np.testing.assert_allclose(path.at(time + turns * path.period), path.at(time), atol=1e-11)
    legs = list(path.legs(2))
    for before, after in itertools.pairwise(legs):
        assert after.start == pytest.approx(before.end, abs=1e-12)
        np.testing.assert_allclose(after.loads(after.start), before.loads(before.end), atol=1e-14)
    assert legs[0].start == path.start
    np.testing.assert_allclose(legs[0].loads(path.start), (0.0, 0.0), atol=1e-15)


@pytest.mark.parametrize("load", periodic_loads().values(), ids=periodic_loads().keys())
def test_at_agrees_with_the_legs_at_any_revolution(load):
    path = load.path()
    for leg in path.legs(3):
        times = np.linspace(leg.start, leg.end, 7)
        np.testing.assert_allclose(path.at(times), leg.loads(times), atol=1e-12)


def test_points_of_the_initial_loading_are_passed():
    load = periodic_loads()["points on the way"]
    path = load.path()
    assert [leg.last for leg in path.initial_loading[:2]] == [(1, 0.5), (2, 0.1)]
    assert [leg.end - leg.start for leg in path.initial_loading] == pytest.approx([math.pi] * 3)


def test_path_that_just_ends():
    path = PolygonLoad(initial_loading=[(2, 0), (2, 1)]).path()
    assert path.period is None
    assert path.cycle == ()
    assert [leg.last for leg in path.legs(5)] == [(2, 0), (2, 1)]
    assert [float(v) for v in path.at(2.0)] == [2.0, 1.0]
    with pytest.raises(ValueError, match=r"runs from 0\.0 to 2\.0"):
        path.at(2.1)
    with pytest.raises(ValueError, match="outside the load path"):
        path.at([-0.1, 0.5])


def test_at_keeps_the_shape_of_time():
    path = periodic_loads()["polygon"].path()
    assert [v.shape for v in path.at(0.5)] == [(), ()]
    assert [v.shape for v in path.at(np.full((2, 3), 0.5))] == [(2, 3), (2, 3)]


@pytest.mark.parametrize("profile", [Hertz(radius=3.0), FlatRounded(radius=3.0, flat_half_length=0.5)])
@given(x=st.floats(0, 100), further=st.floats(0, 100))
def test_gap_is_symmetric_not_negative_and_does_not_fall(profile, x, further):
    here, there = profile.height(x), profile.height(x + further)
    assert 0 <= here <= there
    assert profile.height(-x) == here


def test_gap_of_the_two_profiles():
    assert Hertz(radius=2.0).height([0.0, 1.0, -2.0]).tolist() == [0.0, 0.25, 1.0]
    assert FlatRounded(radius=2.0, flat_half_length=1.0).height([0.0, 1.0, -3.0]).tolist() == [0.0, 0.0, 1.0]
    assert FlatRounded(radius=2.0, flat_half_length=1e-12).height(1.0) == pytest.approx(Hertz(radius=2.0).height(1.0))
