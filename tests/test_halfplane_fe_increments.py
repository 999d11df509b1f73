"""Increments: halved by their step error, halved where they do not converge, and never leaving a trace; the convex halves."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import SolverSettings, stepping
from halfplane_fe.contact import ROUNDING, ContactProblem, InterfaceState
from halfplane_fe.edges import fitted_stick_edge, stick_edges
from halfplane_fe.systems import Layer
from meshes import MeshSettings
from scenes import ConvergenceError, Elastic, InputError, Materials, PolygonLoad, Scene, load_scene

MESH = MeshSettings(element_size=1 / 12, edge_element_size=1 / 30)
UNLIKE = Materials(upper=Elastic(young_modulus=70e3, poisson_ratio=0.33), lower=Elastic(young_modulus=210e3, poisson_ratio=0.3))


def unlike(name: str) -> Scene:
    return load_scene(name).vary(material=UNLIKE)


def test_a_tighter_step_tolerance_halves_more_and_errs_less() -> None:
    scene = load_scene("hertz-paper")
    errors, halved = [], []
    for tolerance in (np.inf, 1e-3, 1e-4):
        answer = halfplane_fe.solve(scene, MESH, SolverSettings(steps_per_cycle=16, step_tolerance=tolerance))
        cycle = answer.last_cycle[1:]
        errors.append(answer.record.energy["step_error"][cycle].sum() / answer.dissipation)
        halved.append(answer.work.counts.get("increments halved, step error", 0))
    assert errors[0] > 5e-3
    assert 2e-3 > errors[1] > errors[2]
    assert halved[0] == 0 < halved[1] < halved[2]


def test_an_increment_that_fails_once_is_halved_and_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    """Failures planted at whole increments: the answer at the regular instants is the one without them."""
    scene = load_scene("cattaneo-mindlin")  # constant P: the answer does not depend on the increments
    settings = SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)
    plain = halfplane_fe.solve(scene, MESH, settings)
    solve = ContactProblem.equilibrium
    failed = set()

    def failing(self: ContactProblem, history: InterfaceState, time: float, loads: tuple[float, float]) -> object:
        if time in {1.25, 2.5, 3.75} and time not in failed:
            failed.add(time)
            raise ConvergenceError("planted")
        return solve(self, history, time, loads)

    monkeypatch.setattr(ContactProblem, "equilibrium", failing)
    halved = halfplane_fe.solve(scene, MESH, settings)
    assert len(failed) == 3
    assert halved.dissipation == pytest.approx(plain.dissipation, rel=1e-10)
    np.testing.assert_allclose(halved.shear[-1], plain.shear[-1], atol=1e-9 * plain.pressure.max())


def test_what_halving_does_not_help_keeps_the_steps_solved_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    solve = ContactProblem.equilibrium

    def failing(self: ContactProblem, history: InterfaceState, time: float, loads: tuple[float, float]) -> object:
        if time > 2.0 and self.interface.x[0] == 0:  # the coarse run, on both halves of the faces, is let through
            raise ConvergenceError("planted")
        return solve(self, history, time, loads)

    monkeypatch.setattr(ContactProblem, "equilibrium", failing)
    with pytest.raises(ConvergenceError, match="planted") as caught:
        halfplane_fe.solve(load_scene("cattaneo-mindlin"), MeshSettings(element_size=1 / 16, edge_element_size=1 / 60))
    partial = caught.value.partial
    assert partial is not None
    assert not partial.record.converged
    assert 1.9 < partial.time[-1] <= 2.0


@pytest.mark.parametrize("name", ["cattaneo-mindlin", "hertz-paper"])
def test_unlike_bodies_keep_every_law(name: str) -> None:
    answer = halfplane_fe.solve(unlike(name), MESH, SolverSettings(steps_per_cycle=32))
    assert max(float(values.max()) for values in answer.record.certificates.values()) < 1e-8
    assert answer.work.counts["condensations"] == 2


def room(history: InterfaceState, state: InterfaceState) -> float:
    """Least of what the nodes have left up to their event, those at it from the start apart; negative behind an event."""
    open_by = state.gap - state.pressure  # within rounding a node keeps its side, and its gap or its force turns negative
    left = np.where(history.closed, -open_by, open_by)
    return float(left[np.where(history.closed, history.pressure, history.gap) > ROUNDING].min())


@pytest.mark.parametrize(
    "scene",
    [load_scene("hertz-paper"), unlike("hertz-paper"), unlike("cattaneo-mindlin")],
    ids=["like", "unlike", "unlike, polygon"],
)
def test_events_are_met_to_a_ten_thousand_millionth_of_the_leg(monkeypatch: pytest.MonkeyPatch, scene: Scene) -> None:
    """By brute force: at a landing every node has room left, just after it one has none."""
    arrive, met = stepping.arrive, []

    def watched(problem, history, loads_at, predicted, end, landing):  # type: ignore[no-untyped-def]
        arrival = arrive(problem, history, loads_at, predicted, end, landing)
        if arrival.event != "regular" and not landing.too_long(arrival.solved) and len(problem.interface.x) > 60:
            later = arrival.solved.time + 5 * landing.within  # 1e-10 of the leg
            met.append((history, arrival.solved, problem.equilibrium(history, later, loads_at(later))[0]))
        return arrival

    monkeypatch.setattr(stepping, "arrive", watched)
    answer = halfplane_fe.solve(scene, MESH, SolverSettings(steps_per_cycle=8, step_tolerance=np.inf))
    assert len(met) > 30
    assert all(room(history, before) > -ROUNDING and room(history, after) < 0 for history, before, after in met)
    assert answer.work.counts.get("events not landed on", 0) == 0
    assert ("landing solves" in answer.work.counts) != scene.material.alike


@pytest.mark.parametrize("stiffer", [0.0, 1e-5, 1e-3])
def test_each_node_touches_at_an_instant_of_its_own(stiffer: float) -> None:
    """A node that closes does so without a gap or without a force: 5e-12 at most. The two sides of bodies that are hardly unlike
    touch so soon after each other that the second node, still open by 1e-8 to 1e-5, must not be taken for met with the first.
    """
    lower, load = Elastic(young_modulus=210e3, poisson_ratio=0.3), PolygonLoad(initial_loading=[(30, 0), (60, 6), (90, -9)])
    upper = lower.model_copy(update={"young_modulus": 210e3 * (1 + stiffer)})
    scene = load_scene("hertz-paper").model_copy(update={"material": Materials(upper=upper, lower=lower), "load": load})
    coarse = MeshSettings(element_size=1 / 4, edge_element_size=1 / 8, far_radius=6.0, growth=0.5)
    states = halfplane_fe.solve(scene, coarse, SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)).states
    closing = [
        np.minimum(before.gap, np.abs(after.pressure) + np.abs(after.gap))[~before.closed & after.closed]
        for before, after in pairwise(states)
    ]
    assert sum(len(part) for part in closing) >= 25
    assert max(float(part.max(initial=0.0)) for part in closing) < 1e-9


NEWTON = ContactProblem._active_set


def no_newton(self: ContactProblem, states: np.ndarray, *rest: object) -> object:
    """Newton's iteration for the normal problem alone."""
    return (None, 1, 0) if self.tangential else NEWTON(self, states, *rest)


def test_the_convex_halves_give_newtons_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """With Newton's iteration switched off the alternating one has to find every state, of like and of unlike bodies."""
    settings = SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)
    for scene, limit in ((load_scene("cattaneo-mindlin"), 1e-10), (unlike("cattaneo-mindlin"), 1e-9)):
        newton = halfplane_fe.solve(scene, MESH, settings)
        with monkeypatch.context() as patch:
            patch.setattr(ContactProblem, "_active_set", no_newton)
            halves = halfplane_fe.solve(scene, MESH, settings)
        assert halves.work.counts["alternating solves"] > 0
        assert halves.dissipation == pytest.approx(newton.dissipation, rel=limit)
        assert max(float(values.max()) for values in halves.record.certificates.values()) < 1e-9


def test_near_gross_sliding_no_node_is_forced_to_stick_beyond_the_cone() -> None:
    """Unlike bodies, f = 0.039, initial loading and cycle at 0.999 of gross sliding: a false convergence here once left q > f p."""
    scene = Scene.model_validate(
        {
            "material": {
                "upper": {"young_modulus": 2e4, "poisson_ratio": 0.1},
                "lower": {"young_modulus": 2.1e5, "poisson_ratio": 0.3},
            },
            "profile": {"kind": "hertz", "radius": 1000.0},
            "friction": {"coefficient": 0.039},
            "load": {
                "kind": "ellipse",
                "mean_normal_load": 100.0,
                "normal_amplitude": 11.0,
                "tangential_amplitude": 3.85,
                "phase_degrees": -87.0,
            },
        }
    )
    answer = halfplane_fe.solve(scene, MESH, SolverSettings(steps_per_cycle=32))
    assert answer.record.certificates["cone"].max() < 1e-9
    assert answer.record.certificates["slip_sign"].max() < 1e-9


def test_a_known_stick_edge_is_fitted_to_a_twentieth_of_an_element() -> None:
    x = np.linspace(0.0, 1.0, 201)
    edge = 0.6037
    room = np.sqrt(np.maximum(edge**2 - x**2, 0.0))
    last = int(np.searchsorted(x, edge)) - 1
    assert fitted_stick_edge(x, room, last, 1) == pytest.approx(edge, abs=0.05 * 2 * x[1])  # the squares are not quite straight
    assert fitted_stick_edge(x, room[::-1].copy(), 100, 1) is None


def test_stick_edge_by_status_forgives_single_nodes_at_the_rim() -> None:
    x = np.linspace(-1, 1, 41)
    closed = np.abs(x) < 0.91
    stick = np.abs(x) < 0.41
    clean = stick_edges(x, stick, closed, (-0.92, 0.92))
    stick[np.abs(np.abs(x) - 0.9) < 1e-9] = True  # just touched
    assert stick_edges(x, stick, closed, (-0.92, 0.92)) == clean == pytest.approx((-0.425, 0.425))
    assert np.isnan(stick_edges(x, stick & False, closed, (-0.92, 0.92))).all()


def test_settings_refuse_what_makes_no_sense() -> None:
    with pytest.raises(InputError, match="step_tolerance"):
        SolverSettings(step_tolerance=0.0)
    with pytest.raises(InputError, match="upper_ratio"):
        MeshSettings(upper_ratio=100.0)


def test_a_stiff_layer_tends_to_the_exact_law() -> None:
    zero = Layer(np.zeros(3), np.zeros(3))
    assert not zero.normal.any()
    scene = load_scene("cattaneo-mindlin")
    settings = {"steps_per_cycle": 16, "step_tolerance": np.inf}
    exact = halfplane_fe.solve(scene, MESH, SolverSettings(**settings)).dissipation
    errors = [
        halfplane_fe.solve(
            scene, MESH, SolverSettings(method="penalty", normal_stiffness=k, tangential_stiffness=k, **settings)
        ).dissipation
        / exact
        - 1
        for k in (1e2, 1e3, 1e4)
    ]
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert np.all((ratios > 5) & (ratios < 20)), errors


def test_halving_that_never_arrives_ends_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every trial is to be halved: the same instant was tried for ever."""
    calls = []

    def stuck(*arguments: object) -> float:
        calls.append(arguments)
        assert len(calls) < 100_000, "a loop without end"
        return 0.0

    monkeypatch.setattr(stepping, "_attempt", stuck)
    with pytest.raises(ConvergenceError, match="was not reached: nodes touch and let go without end"):
        halfplane_fe.solve(load_scene("cattaneo-mindlin"), MESH)
