"""Planted faults: the claims below hold for the engine as it is, and at least one of them must break for each mutant."""

import dataclasses

import numpy as np
import pytest

import semi_analytic.fields
import semi_analytic.history
import semi_analytic.load_series
from scenes import StraightSegment, SurfaceState, load_scene
from semi_analytic import solve
from semi_analytic.fields import Arc, Integrals
from semi_analytic.load_series import Knot
from semi_analytic.memory import Piece

NAMES = ("cattaneo-mindlin", "hertz-paper")


def broken_claims(name):
    """The claims that fail, by name; no knowledge of how the engine works."""
    scene = load_scene(name)
    solution = solve(scene)
    limit = scene.friction.coefficient * solution.pressure
    size = np.max(limit)
    forward, reverse = (solution.state == state for state in (SurfaceState.SLIP_FORWARD, SurfaceState.SLIP_REVERSE))
    weight = np.gradient(solution.x)
    force = np.sum(weight * solution.shear, axis=1)
    claims = {
        "inside the cone": np.max(np.abs(solution.shear) - limit) <= 1e-12 * size,
        "at the limit in forward slip": np.allclose(solution.shear[forward], limit[forward], atol=1e-11 * size),
        "at the limit in reverse slip": np.allclose(solution.shear[reverse], -limit[reverse], atol=1e-11 * size),
        "carries Q": np.allclose(force, solution.tangential_load, atol=5e-3 * np.max(np.abs(solution.tangential_load))),
        "slip zones exist": np.any(forward) and np.any(reverse),
        "energy balance": np.isclose(solution.dissipation, solution.loop_work, rtol=1e-10),
        "dissipation": solution.dissipation > 0,
        "stick stands still": still(solution),
    }
    return {claim for claim, holds in claims.items() if not holds}


def still(solution):
    stuck = (solution.state[1:] == SurfaceState.STICK) & (solution.state[:-1] == SurfaceState.STICK)
    return np.max(np.abs(np.diff(solution.slip, axis=0)[stuck])) <= 1e-12 * np.max(np.abs(solution.slip))


@pytest.mark.parametrize("name", NAMES)
def test_every_claim_holds_for_the_engine_itself(name):
    assert broken_claims(name) == set()


def drop_history(monkeypatch):
    """Each leg starts as if its first point had been reached along a straight line."""
    march = semi_analytic.history.march

    def forgetful(curve, legs, friction, delay):
        if curve is not None:
            end = curve.anchor
            leg = StraightSegment(-1.0, 0.0, (0.0, 0.0), (end.normal, end.tangential))
            curve = Piece(None, end.normal, end._replace(leg=leg, time=0.0), end.tangential / end.normal)
        return march(curve, legs, friction, delay)

    monkeypatch.setattr(semi_analytic.history, "march", forgetful)
    step = semi_analytic.load_series._step

    def forgetful_step(curve, *given):
        return step(None if curve is None else Knot(None, *curve[1:3], *curve[1:3], 1), *given)

    monkeypatch.setattr(semi_analytic.load_series, "_step", forgetful_step)


def flip_change_of_shear(monkeypatch):
    """Slip to the left where it should go to the right."""
    level = semi_analytic.history.level
    monkeypatch.setattr(semi_analytic.history, "level", lambda direction, friction: level(-direction, friction))
    slip = semi_analytic.load_series._slip
    monkeypatch.setattr(semi_analytic.load_series, "_slip", lambda curve, s, *given: slip(curve, -s, *given))


def forget_friction(monkeypatch):
    """The line of slip has slope 0."""
    slip_to = semi_analytic.history.slip_to
    monkeypatch.setattr(semi_analytic.history, "slip_to", lambda curve, s, f, end, slipped: slip_to(curve, s, 0.0, end, slipped))
    slip = semi_analytic.load_series._slip
    monkeypatch.setattr(semi_analytic.load_series, "_slip", lambda *given: slip(*given)._replace(rise=0.0))


def shear_is_pressure(monkeypatch):
    """The shear kernel is handed the pressure of the whole load."""
    over = Integrals.over

    def mutant(self, snapshot):
        if self.kernel != "shear":
            return over(self, snapshot)
        return snapshot.friction * self.contact.pressure(self.x, snapshot.load[:, None])

    monkeypatch.setattr(Integrals, "over", mutant)


def lose_the_arc(monkeypatch):
    """The traction that an appended arc leaves is left out."""
    up_to = Arc.up_to
    monkeypatch.setattr(Arc, "up_to", lambda self, time: (self._kernel != "shear") * up_to(self, time))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("mutate", [drop_history, flip_change_of_shear, forget_friction, shear_is_pressure])
def test_planted_faults_are_seen(name, mutate, monkeypatch):
    mutate(monkeypatch)
    try:
        broken = broken_claims(name)
    except (ValueError, ArithmeticError, RuntimeWarning) as reason:
        broken = {f"raised {type(reason).__name__}"}
    assert broken, mutate.__doc__


def test_a_lost_arc_is_seen(monkeypatch):
    lose_the_arc(monkeypatch)
    assert broken_claims("hertz-paper") & {"inside the cone", "carries Q"}


def test_friction_itself_matters():
    """f -> 0 is not a detail: with a tenth less friction more slips, with a thousandth of it the path is refused."""
    scene = load_scene("cattaneo-mindlin")
    less = dataclasses.asdict(solve(scene, x=[0.0]))["dissipation"]
    friction = scene.friction.vary(coefficient=0.45)
    more = solve(scene.vary(friction=friction), x=[0.0]).dissipation
    assert more > 1.1 * less
    with pytest.raises(ValueError, match="gross sliding"):
        solve(scene.vary(friction=5e-4))
