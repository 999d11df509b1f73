"""The active set of one increment: history is a value, mirror, penalty and exact law, unlike bodies, failure with its record."""

import functools
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halfplane_fe
from halfplane_fe import SolverSettings
from halfplane_fe.contact import ContactProblem, untouched
from halfplane_fe.elasticity import condense
from halfplane_fe.energy import certificates, increment_energy
from halfplane_fe.interface import couple
from halfplane_fe.law import slip_sign
from halfplane_fe.systems import Layer
from meshes import SurfaceGrading, half_disc
from problems import COARSE
from scenes import ConvergenceError, Elastic, InputError, SurfaceState, load_scene
from tolerances import check_order

FRICTION = 0.5
MATERIALS = {
    "like": (Elastic(young_modulus=1.82, poisson_ratio=0.3),) * 2,
    "unlike": (Elastic(young_modulus=1.82, poisson_ratio=0.3), Elastic(young_modulus=0.6, poisson_ratio=0.33)),
}
# f, P in the units of the largest load; each a path from rest, without gross sliding.
PATH = ((0.5, 0.0), (1.0, 0.2), (0.9, 0.38), (0.7, -0.1), (0.95, -0.4), (0.6, 0.05))


@functools.cache
def interface(pair="like"):
    body = half_disc("body", SurfaceGrading(0.0, 1.2, 1 / 10, 1 / 10, 6.0), 0.4, 2)
    lower, upper = MATERIALS[pair]
    below = condense(body, lower, 1.0)
    above = below if upper is lower else condense(body, upper, 1.0)
    return couple(below, above)


def problem(pair="like", layer=0.0, friction=FRICTION, max_iterations=100):
    """Scaled so that E* = 1 and the contact reaches |x| = 1 at P = 1, or thereabouts."""
    sides = interface(pair)
    soft = np.full_like(sides.x, layer)
    modulus = 1 / sum((1 - one.poisson_ratio**2) / one.young_modulus for one in MATERIALS[pair])
    height = 2 / np.pi / modulus * np.square(sides.x)
    return ContactProblem(sides, height, friction, Layer(soft, soft), max_iterations=max_iterations)


def walk(contact, path=PATH):
    """States along a path, the untouched one first."""
    states = [untouched(contact.height, 0.0)]
    for time, loads in enumerate(path, start=1):
        states.append(contact.equilibrium(states[-1], float(time), loads)[0])
    return states


def bits(state):
    """All of a state as bytes."""
    arrays = (state.pressure, state.shear, state.gap, state.slip, state.state)
    return b"".join(array.tobytes() for array in arrays) + np.array([state.approach, state.shift, state.time]).tobytes()


# ------------------------------------------------------------------------------------------------------ history is a value
@pytest.mark.parametrize("pair", MATERIALS)
def test_the_same_history_gives_the_same_bits_whatever_was_tried_in_between(pair):
    contact = problem(pair)
    states = walk(contact)
    for before, after, loads in zip(states[:-1], states[1:], PATH, strict=True):
        contact.equilibrium(before, 99.0, (0.8, 0.3))  # a step that is thrown away
        contact.holding(before, 99.0, (0.3, -0.1))
        again, _ = contact.equilibrium(before, after.time, loads)
        assert bits(again) == bits(after)
    fresh = walk(problem(pair))
    assert [bits(state) for state in fresh] == [bits(state) for state in states]


def test_history_is_read_only_and_matters():
    contact = problem()
    states = walk(contact)
    for name in ("pressure", "shear", "gap", "slip", "state"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(states[-1], name)[0] = 1
    forgetful, _ = contact.equilibrium(untouched(contact.height, 0.0), 6.0, PATH[-1])
    np.testing.assert_allclose(forgetful.pressure, states[-1].pressure, atol=1e-12)  # pressure has no memory
    assert np.abs(forgetful.shear - states[-1].shear).max() > 0.1 * np.abs(states[-1].shear).max()  # shear has


def test_increments_of_constant_pressure_may_be_split():
    """Mindlin's loading in one increment or in seven: the same state."""
    contact = problem()
    pressed, _ = contact.equilibrium(untouched(contact.height, 0.0), 1.0, (1.0, 0.0))
    at_once, _ = contact.equilibrium(pressed, 2.0, (1.0, 0.4))
    state = pressed
    for k in range(1, 8):
        state, _ = contact.equilibrium(state, 1 + k / 7, (1.0, 0.4 * k / 7))
    np.testing.assert_allclose(state.shear, at_once.shear, atol=1e-13)
    np.testing.assert_allclose(state.slip, at_once.slip, atol=1e-13)


# -------------------------------------------------------------------------------------------------------- laws on any path
loads = st.tuples(st.floats(0.3, 1.0), st.floats(-0.97, 0.97)).map(lambda point: (point[0], FRICTION * point[0] * point[1]))


@pytest.mark.parametrize("pair", MATERIALS)
@settings(max_examples=25)
@given(st.lists(loads, min_size=1, max_size=5))
def test_every_law_holds_along_any_path(pair, path):
    contact = problem(pair)
    states = walk(contact, path)
    for before, after in itertools.pairwise(states):
        found = certificates(contact, before, after)
        assert max(found.values()) < 1e-9, found
        energy = increment_energy(contact, before, after)
        assert energy.external == pytest.approx(energy.elastic + energy.interface, abs=1e-12)
        assert np.all(energy.dissipation >= 0)
        friction = float(after.shear @ (after.slip - before.slip))
        assert friction >= -1e-12  # at the end of the increment friction takes, never gives


@pytest.mark.parametrize("pair", MATERIALS)
@settings(max_examples=15)
@given(st.lists(loads, min_size=1, max_size=4))
def test_mirrored_path_has_the_mirrored_answer(pair, path):
    """Q -> -Q: p(x) -> p(-x), q(x) -> -q(-x), s(x) -> -s(-x)."""
    states = walk(problem(pair), path)
    mirrored = walk(problem(pair), [(p, -q) for p, q in path])
    for one, other in zip(states, mirrored, strict=True):
        np.testing.assert_allclose(other.pressure, one.pressure[::-1], atol=1e-10)
        np.testing.assert_allclose(other.shear, -one.shear[::-1], atol=1e-10)
        np.testing.assert_allclose(other.gap, one.gap[::-1], atol=1e-10)
        open_now = one.state == SurfaceState.OPEN
        np.testing.assert_allclose(other.slip[::-1][~open_now], -one.slip[~open_now], atol=1e-10)
        assert other.shift == pytest.approx(-one.shift, abs=1e-10)


def test_like_bodies_keep_normal_and_tangential_apart_and_unlike_ones_do_not():
    pressed = {pair: walk(problem(pair), [(1.0, 0.0)])[-1] for pair in MATERIALS}
    np.testing.assert_array_equal(pressed["like"].shear, 0.0)
    shear = pressed["unlike"].shear
    assert np.abs(shear).max() > 0.05 * pressed["unlike"].pressure.max()
    np.testing.assert_allclose(shear, -shear[::-1], atol=1e-12)
    # A pressed face is drawn inwards, by (1-2 nu)(1+nu)/E: that of the softer upper body more, so it drags the lower one inwards.
    right = interface("unlike").x > 0.2
    closed = pressed["unlike"].closed
    assert np.all(shear[right & closed] < 0)


# ---------------------------------------------------------------------------------------------------- penalty and exact law
def penalty_errors(compliances):
    exact = walk(problem())
    errors = []
    for layer in compliances:
        soft = walk(problem(layer=layer))
        errors.append(
            [
                max(np.abs(getattr(a, name) - getattr(b, name)).max() for a, b in zip(soft, exact, strict=True))
                for name in ("pressure", "shear")
            ]
        )
    return np.array(errors).T


def test_penalty_error_falls_linearly_with_the_stiffness():
    compliances = (1e-4, 1e-5, 1e-6)
    for errors in penalty_errors(compliances):
        check_order("penalty", compliances, errors)


@pytest.mark.parametrize("layer", [1e-1, 1e-3])
def test_penalty_is_the_law_with_a_layer_between_the_faces(layer):
    """The inner faces keep the law exactly; the bodies overlap by layer times force, and creep by it."""
    contact = problem(layer=layer)
    states = walk(contact)
    for before, after in itertools.pairwise(states):
        assert max(certificates(contact, before, after).values()) < 1e-9
    last, sides = states[-1], contact.interface
    bodies_gap = contact.height - last.approach + sides.normal @ last.pressure
    np.testing.assert_allclose(bodies_gap[last.closed], -layer * last.pressure[last.closed], atol=1e-12)
    bodies_slip = last.shift - sides.tangential @ last.shear
    np.testing.assert_allclose(bodies_slip, last.slip + layer * last.shear, atol=1e-12)


# ------------------------------------------------------------------------------------------------------------ failure
def test_too_few_iterations_raise_with_instant_loads_and_count(monkeypatch):
    monkeypatch.setattr(ContactProblem, "_alternating", lambda self, *rest: (None, 1, 1))  # no second way out
    contact = problem(max_iterations=1)
    pressed, _ = problem().equilibrium(untouched(contact.height, 0.0), 1.0, (1.0, 0.0))
    with pytest.raises(
        ConvergenceError, match=r"nodes still change state after \d+ iterations at time 2, normal load 1, tangential"
    ):
        contact.equilibrium(pressed, 2.0, (1.0, 0.45))


def test_solve_raises_and_keeps_the_steps_solved_so_far(monkeypatch):
    """Two iterations are enough for initial loading, not for slip: what was solved is kept, and says that."""
    monkeypatch.setattr(ContactProblem, "_alternating", lambda self, *rest: (None, 1, 1))
    scene = load_scene("hertz-paper")
    with pytest.raises(ConvergenceError, match=r"after \d+ iterations at time .* normal load .* tangential load") as caught:
        halfplane_fe.solve(scene, COARSE, SolverSettings(steps_per_cycle=8, max_iterations=2, step_tolerance=np.inf))
    partial = caught.value.partial
    assert partial is not None
    assert (partial.record.converged, partial.record.termination) == (False, "not converged")
    assert partial.record.message == str(caught.value)
    path = scene.load.path()
    assert path.start < partial.time[-1] < path.cycle_start + path.period
    assert partial.pressure.shape == (len(partial.time), len(partial.x))
    assert partial.pressure[-1].max() > 0
    assert np.all(np.diff(partial.time) > 0)


@pytest.mark.parametrize(
    ("bad", "rule"),
    [
        ({"method": "mortar"}, "method = 'mortar' is refused"),
        ({"normal_stiffness": 0.0}, "normal_stiffness = 0.0"),
        ({"tangential_stiffness": float("nan")}, "tangential_stiffness = nan"),
        ({"steps_per_cycle": 3}, "steps_per_cycle = 3"),
        ({"max_iterations": 1}, "max_iterations = 1"),
    ],
)
def test_settings_refuse_bad_values(bad, rule):
    with pytest.raises(InputError, match=rule):
        SolverSettings(**bad)


def test_some_node_always_sticks_short_of_gross_sliding():
    contact = problem()
    pressed, _ = contact.equilibrium(untouched(contact.height, 0.0), 1.0, (1.0, 0.0))
    for share in (0.9, 0.99, 0.999999):
        state, _ = contact.equilibrium(pressed, 2.0, (1.0, share * FRICTION))
        assert np.any(state.state == SurfaceState.STICK)
        assert np.all(slip_sign(state.state) >= 0)
        assert max(certificates(contact, pressed, state).values()) < 1e-9
