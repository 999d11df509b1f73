"""Penalty and augmented Lagrangian: what the layer costs falls as 1/stiffness and is told; the exact law knows no stiffness."""

import functools
from importlib import import_module

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import SolverSettings
from halfplane_fe.law import project
from problems import COARSE, fe_run
from reports.comparison.laws import certificates
from scenes import SurfaceState, load_scene
from tolerances import check, check_order

STIFFNESS = (1e2, 1e3, 1e4)
SCENES = ("cattaneo-mindlin", "hertz-paper")


@functools.cache
def run(name, method, stiffness=1e3):
    settings = SolverSettings(
        method=method, normal_stiffness=stiffness, tangential_stiffness=stiffness, steps_per_cycle=24, step_tolerance=np.inf
    )
    return fe_run(load_scene(name), COARSE, settings)


def exact(name):
    return run(name, "augmented_lagrangian")


@pytest.mark.parametrize("name", SCENES)
def test_augmented_lagrangian_is_independent_of_the_weights_over_six_decades(name):
    """To the last bit: where the law is met the projection of (p - r g, q + r ds) is (p, q) for any r."""
    plain = run(name, "augmented_lagrangian", 1e3)
    for weight in (1.0, 1e6):
        other = run(name, "augmented_lagrangian", weight)
        for field in ("time", "pressure", "shear", "slip", "state"):
            np.testing.assert_array_equal(getattr(other, field), getattr(plain, field), err_msg=f"{field}, {weight:g}")
        assert other.work.counts["contact iterations"] == plain.work.counts["contact iterations"]


def test_the_weights_are_those_of_the_settings_and_set_the_trial_tractions(monkeypatch):
    """Else the test above would see nothing: where the law is not met yet, the projection does depend on them."""
    solve, made = import_module("halfplane_fe.solve"), []
    make = solve.ContactProblem
    monkeypatch.setattr(solve, "ContactProblem", lambda *given: made.append(make(*given)) or made[-1])
    for weight in (1.0, 1e6):
        halfplane_fe.solve(load_scene("hertz-normal"), COARSE, SolverSettings(normal_stiffness=weight, tangential_stiffness=weight))
    low, high = (problem.augmentation for problem in made[::2])  # each is followed by its half
    for one, other in zip(low, high, strict=True):
        np.testing.assert_allclose(np.asarray(other), 1e6 * np.asarray(one))
    gap = np.full_like(made[0].height, 1e-9)
    states = [project(1e-6 - r * gap, 0 * gap, 0.5)[2] for r in (low[0], high[0])]
    assert np.all(states[0] == SurfaceState.STICK)
    assert np.any(states[1] == SurfaceState.OPEN)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("quantity", ["penetration", "elastic_slip", "creep", "dissipation"])
def test_what_the_layer_costs_falls_as_one_over_the_stiffness(name, quantity):
    costs = [
        abs(answer.dissipation / exact(name).dissipation - 1) if quantity == "dissipation" else getattr(answer.penalty, quantity)
        for answer in (run(name, "penalty", k) for k in STIFFNESS)
    ]
    check_order("penalty", [1 / k for k in STIFFNESS], costs)


@pytest.mark.parametrize("name", SCENES)
def test_audit_is_nothing_for_the_exact_law(name):
    answer = exact(name)
    audit = answer.penalty
    assert np.isinf([audit.normal_stiffness, audit.tangential_stiffness]).all()
    assert (audit.penetration, audit.elastic_slip) == (0.0, 0.0)
    check("certificates", audit.creep_share)  # rounding of slips that do not change
    assert not any("layer" in note for note in answer.record.notes)
    assert answer.settings["penalty"] == {}


def test_audit_is_what_the_bodies_do():
    """From the compliance of the bodies alone: they overlap where they touch, and move against each other where they stick."""
    answer = run("hertz-paper", "penalty", 1e2)
    audit, weights, unit = answer.penalty, answer.condensed[0].weights, answer.scales.load / answer.scales.modulus
    layer = answer.pressure / audit.normal_stiffness
    assert audit.normal_stiffness == pytest.approx(1e2 * answer.scales.modulus / answer.settings["element_size"])
    assert audit.penetration == pytest.approx(layer.max())
    one, other = (body.compliance[1, :, 1, :] for body in answer.condensed)
    height = answer.scene.profile.height(answer.x)
    last = len(answer.time) - 1
    closed = answer.states[last].closed
    gap = height - answer.normal_approach[last] + (one + other) @ (answer.pressure[last] * weights)
    np.testing.assert_allclose(gap[closed], -layer[last][closed], atol=1e-10 * unit)
    assert audit.penetration_share == pytest.approx(
        audit.penetration / (answer.contact_half_width.max() ** 2 / (2 * answer.scene.profile.radius))
    )
    stuck = np.abs(answer.x) < 0.5 * answer.permanent_stick_half_width
    cycle = answer.last_cycle
    assert 0.2 * audit.creep < np.ptp(answer.slip[cycle][:, stuck], axis=0).max() <= audit.creep


def test_audit_is_told_in_the_record_and_breaks_no_law():
    answer = run("hertz-paper", "penalty", 1e2)
    note = answer.record.notes[0]
    assert note.startswith("penalty layer, stiffness ")
    assert f"overlap by up to {answer.penalty.penetration:.2g} [length]" in note
    assert f"creep by up to {answer.penalty.creep:.2g}" in note
    assert answer.settings["penalty"]["creep"] == answer.penalty.creep
    assert all(check.holds for check in certificates(answer))


def test_where_nothing_slips_shares_of_slip_are_no_numbers():
    audit = fe_run(load_scene("hertz-normal"), COARSE, SolverSettings(method="penalty")).penalty
    assert audit.penetration > 0
    assert audit.elastic_slip == 0
    assert np.isnan([audit.elastic_slip_share, audit.creep_share]).all()
