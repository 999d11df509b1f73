"""Solved on one half of mirrored faces: the answer is that of all nodes, and faces that are no mirror images are left alone."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import SolverSettings
from halfplane_fe.interface import couple
from halfplane_fe.mirror import half, mirrored
from problems import COARSE, FEW_STEPS, fe_run
from scenes import load_scene

SOLVE = import_module("halfplane_fe.solve")
PENALTY = SolverSettings(steps_per_cycle=48, method="penalty", normal_stiffness=5.0, tangential_stiffness=5.0)


@pytest.mark.parametrize(
    ("name", "settings"), [("hertz-paper", FEW_STEPS), ("flat-rounded-paper", FEW_STEPS), ("hertz-paper", PENALTY)]
)
def test_half_the_nodes_give_the_answer_of_all(name, settings, monkeypatch):
    scene = load_scene(name)
    halved = fe_run(scene, COARSE, settings)
    assert "contact nodes" in halved.work.skipped
    monkeypatch.setattr(SOLVE, "mirrored", lambda faces: False)
    full = halfplane_fe.solve(scene, COARSE, settings)
    for field in (
        "time",
        "pressure",
        "shear",
        "slip",
        "contact_edges",
        "stick_edges",
        "dissipation_density",
        "tangential_displacement",
    ):
        expected, found = getattr(full, field), getattr(halved, field)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.nanmax(np.abs(expected)), err_msg=field)
    np.testing.assert_array_equal(halved.state, full.state)
    assert halved.dissipation == pytest.approx(full.dissipation, rel=1e-11)


def test_energies_and_certificates_are_those_of_both_halves():
    answer = fe_run(load_scene("hertz-paper"))
    assert max(float(values.max()) for values in answer.record.certificates.values()) < 1e-9
    np.testing.assert_allclose(answer.pressure @ answer.condensed[0].weights, answer.normal_load, rtol=1e-10)


def faces():
    answer = fe_run(load_scene("hertz-paper"))
    return couple(*answer.condensed)


def test_a_force_shared_with_its_image_moves_both_alike():
    whole = faces()
    middle = len(whole.x) // 2
    together = np.cos(whole.x[middle:])
    shared = np.concatenate([together[:0:-1] / 2, together[:1], together[1:] / 2])
    np.testing.assert_allclose(half(whole).normal @ together, (whole.normal @ shared)[middle:], rtol=1e-9)
    np.testing.assert_allclose(half(whole).weights.sum(), whole.weights.sum())


@pytest.mark.parametrize(
    "spoil",
    [
        lambda one: {"x": one.x + 1e-3},
        lambda one: {"gap": one.gap + one.x},
        lambda one: {"normals": np.stack([0.1 * one.x, np.ones_like(one.x)])},
        lambda one: {"weights": one.weights * (1 + 0.1 * (one.x > 0))},
        lambda one: {"normal": one.normal * (1 + 1e-6 * (one.x > 0))},
        lambda one: {"coupling": one.normal},
    ],
    ids=["places", "gap", "slope", "weights", "compliance", "coupling"],
)
def test_faces_that_are_no_mirror_images_are_left_alone(spoil):
    whole = faces()
    assert mirrored(whole)
    assert not mirrored(replace(whole, **spoil(whole)))
