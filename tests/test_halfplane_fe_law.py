"""The contact law at a point: properties of the projection, and violations that are planted and seen."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from halfplane_fe.law import project, slip_sign, violations
from scenes import SurfaceState

number = st.floats(-1e3, 1e3).map(lambda value: 0.0 if abs(value) < 1e-6 else value)
friction = st.floats(0, 3).map(lambda value: 0.0 if value < 1e-6 else value)  # products stay normal numbers
trials = arrays(float, 6, elements=number)
OPEN, STICK, FORWARD, REVERSE = SurfaceState


@given(trials, trials, friction)
def test_projection_is_idempotent(pressure, shear, f):
    p, q, state = project(pressure, shear, f)
    again = project(p, q, f)
    np.testing.assert_array_equal(again[0], p)
    np.testing.assert_array_equal(again[1], q)
    # What lies on the cone needs no moving: there it counts as sticking.
    assert np.all((again[2] == STICK) | (state == OPEN))


@given(trials, trials, friction)
def test_projection_lies_in_the_cone(pressure, shear, f):
    p, q, state = project(pressure, shear, f)
    assert np.all(p >= 0)
    assert np.all(np.abs(q) <= f * p)
    sliding = slip_sign(state)
    np.testing.assert_array_equal(q[sliding != 0], (sliding * f * p)[sliding != 0])
    np.testing.assert_array_equal(p[state == OPEN], 0.0)
    np.testing.assert_array_equal(q[state == STICK], np.asarray(shear)[state == STICK])


@given(trials, trials, friction)
def test_mirrored_trial_has_the_mirrored_answer(pressure, shear, f):
    p, q, state = project(pressure, shear, f)
    p_mirrored, q_mirrored, state_mirrored = project(pressure, -shear, f)
    np.testing.assert_array_equal(p_mirrored, p)
    np.testing.assert_array_equal(q_mirrored, -q)
    np.testing.assert_array_equal(slip_sign(state_mirrored), -slip_sign(state))


@given(trials, trials, friction, st.integers(-40, 40))
def test_projection_knows_no_scale(pressure, shear, f, power):
    """By powers of two, so that scaling itself does not round."""
    scale = 2.0**power
    p, q, state = project(pressure, shear, f)
    p_scaled, q_scaled, state_scaled = project(scale * pressure, scale * shear, f)
    # Not where a number is so small that even a power of two rounds it.
    normal = np.min([np.abs(pressure), np.abs(shear), f * np.abs(pressure)], axis=0) > 1e-280
    np.testing.assert_array_equal(p_scaled[normal], (scale * p)[normal])
    np.testing.assert_array_equal(q_scaled[normal], (scale * q)[normal])
    np.testing.assert_array_equal(state_scaled[normal], state[normal])


some = st.floats(0, 10)


@given(st.floats(1e-3, 1e3), st.floats(-1, 1), st.floats(0.01, 3), some, some, st.floats(1e-3, 1e3))
def test_law_is_the_fixed_point_of_the_projection(p, share, f, gap, slip, r):
    """(p, q) = project(p - r g, q + r ds) where, and only where, Signorini's and Coulomb's laws hold; for any r > 0."""
    # stick inside the cone
    found = project(p, share * f * p, f)
    assert (float(found[0]), float(found[1])) == (p, share * f * p)
    # slip on the cone, either way
    for sense in (1.0, -1.0):
        found = project(p, sense * f * p + r * sense * slip, f)
        assert (float(found[0]), float(found[1])) == (p, sense * f * p)
    # open
    assert [float(v) for v in project(-r * gap, 0.0, f)[:2]] == [0.0, 0.0]


@given(p=st.floats(1e-2, 1e2), f=st.floats(0.01, 3), wrong=st.floats(1e-3, 10))
def test_what_breaks_the_law_is_no_fixed_point(p, f, wrong):
    breaches = {
        "penetration": (p + wrong, 0.0, p, 0.0),
        "pressure on an open gap": (p - wrong, 0.0, p, 0.0),
        "slip inside the cone": (p, 0.5 * f * p + wrong, p, 0.5 * f * p),
        "slip against friction": (p, f * p - wrong, p, f * p),
    }
    for name, (trial_p, trial_q, own_p, own_q) in breaches.items():
        found = project(trial_p, trial_q, f)
        assert (float(found[0]), float(found[1])) != (own_p, own_q), name


def test_states_and_shapes():
    p, q, state = project(np.full((2, 2), 2.0), [[0.0, 0.9], [1.1, -1.1]], 0.5)
    assert p.shape == q.shape == state.shape == (2, 2)
    assert state.tolist() == [[STICK, STICK], [FORWARD, REVERSE]]
    assert state.dtype == np.int8
    assert project(0.0, 1.0, 0.5)[2] == OPEN


def test_no_friction_no_shear():
    p, q, state = project([1.0, 1.0], [0.0, 0.3], 0.0)
    assert q.tolist() == [0.0, 0.0]
    assert state.tolist() == [STICK, FORWARD]
    assert p.tolist() == [1.0, 1.0]


# An answer in which all is well: open, sticking, sliding forward, sliding in reverse.
GOOD = {
    "gap": np.array([0.5, 0.0, 0.0, 0.0]),
    "pressure": np.array([0.0, 2.0, 2.0, 4.0]),
    "shear": np.array([0.0, 0.4, 1.0, -2.0]),
    "slip_increment": np.array([0.3, 0.0, 0.1, -0.2]),
}
PLANTED = {
    "tension": ("pressure", 0, -0.25, {"tension": 0.25, "gap_pressure": 0.125, "cone": 0.125}),
    "penetration": ("gap", 1, -0.25, {"penetration": 0.25, "gap_pressure": 0.5}),
    "gap_pressure": ("gap", 3, 0.25, {"gap_pressure": 1.0}),
    "cone": ("shear", 2, 1.25, {"cone": 0.25}),
    "slip_sign": ("slip_increment", 3, 0.25, {"slip_sign": 0.5}),
    "creep": ("slip_increment", 1, -0.25, {"creep": 0.25, "slip_sign": 0.1}),
}


def test_a_good_answer_violates_nothing():
    assert max(violations(**GOOD, friction=0.5).values()) == 0.0


@pytest.mark.parametrize("name", PLANTED)
def test_planted_violation_is_seen_with_its_size_and_nothing_else_is(name):
    field, place, value, seen = PLANTED[name]
    values = GOOD[field].copy()
    values[place] = value
    found = violations(**(GOOD | {field: values}), friction=0.5)
    assert set(found) == set(PLANTED)
    for figure in PLANTED:
        assert found[figure] == pytest.approx(seen.get(figure, 0.0), abs=1e-15), figure


@given(trials, trials, st.floats(0.01, 3), arrays(float, 6, elements=st.floats(0, 10)))
def test_projected_answers_violate_nothing(pressure, shear, f, amount):
    p, q, state = project(pressure, shear, f)
    assume(np.all(p[p > 0] > 1e-6))
    gap = np.where(state == OPEN, amount, 0.0)
    found = violations(gap, p, q, slip_sign(state) * amount, f)
    assert max(found.values()) == 0.0
