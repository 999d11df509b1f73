"""Return mapping of the tractions: penalty method and augmented Lagrangian beside the active set.

The active set reads the states of `law.project` alone, the return mapping its tractions: two routes
to one answer, which planted faults of the tractions part.
"""

import importlib
from functools import cache, partial

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import FiniteElementSolution, SolverSettings, law, return_mapping
from meshes import MeshSettings
from scenes import SLIP_FORWARD, ConvergenceError, Elastic, Materials, Scene, load_scene

UNLIKE = Materials(
    upper=Elastic(young_modulus=70e3, poisson_ratio=0.33),
    lower=Elastic(young_modulus=210e3, poisson_ratio=0.3),
)

COARSER = MeshSettings(element_size=1 / 6, edge_element_size=1 / 10, far_radius=6.0, growth=0.5)
# Of a nodal traction, over the largest that friction carries; of W. The multipliers are met to
# 1e-10 of the largest nodal force.
TRACTIONS = 1e-7
WORK = 1e-9
LEAST_WORK = 1e-10  # over A f^2 P^2: where W is next to nothing

FAST = ("hertz-paper", "unlike, f = 0.3", "tilted-flat-pad")
SLOW = (
    "unlike-beta-fifth",
    "unlike, f = 0.1",
    "unlike, f = 1",
    "unlike, f = 3",
    "near-sliding",
    "unload-reload",
    "nowell-hills",
    "cylinder-roller",
    "dovetail-out-of-phase",
    "flat-rounded-paper",
)


def scene_named(name: str) -> Scene:
    """A scene of the library; or the paper's between unlike bodies with a coefficient of friction,
    Q in proportion to it.
    """
    if not name.startswith("unlike, f = "):
        return load_scene(name)
    friction = float(name.removeprefix("unlike, f = "))
    scene = load_scene("hertz-paper")
    load = scene.load
    factor = friction / scene.friction.coefficient
    in_proportion = {
        key: factor * getattr(load, key) for key in ("mean_tangential_load", "tangential_amplitude")
    }
    return scene.vary(
        material=UNLIKE,
        friction=scene.friction.model_copy(update={"coefficient": friction}),
        load=load.model_copy(update=in_proportion),
    )


def solved(name: str, **settings: object) -> FiniteElementSolution:
    options = {"steps_per_cycle": 16, "step_tolerance": np.inf} | settings
    return halfplane_fe.solve(scene_named(name), COARSER, SolverSettings(**options))


@cache
def by_active_set(name: str) -> FiniteElementSolution:
    return solved(name)


def assert_same(answer: FiniteElementSolution, reference: FiniteElementSolution) -> None:
    """The same increments, tractions and dissipation."""
    assert len(answer.time) == len(reference.time)
    for event in ("regular", "touch", "release"):
        key = f"{event} increments"
        assert answer.work.counts.get(key) == reference.work.counts.get(key), key
    friction = reference.scene.friction.coefficient
    largest = reference.pressure.max()
    np.testing.assert_allclose(answer.time, reference.time, atol=1e-7)
    np.testing.assert_allclose(
        answer.pressure, reference.pressure, rtol=0, atol=TRACTIONS * largest * min(1, friction)
    )
    np.testing.assert_allclose(
        answer.shear, reference.shear, rtol=0, atol=TRACTIONS * largest * friction
    )
    unit = 2 * (friction * reference.normal_load.max()) ** 2 / reference.scales.modulus
    assert answer.dissipation == pytest.approx(
        reference.dissipation, rel=WORK, abs=LEAST_WORK * unit
    )


@pytest.mark.parametrize(
    "name", [*FAST, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)]
)
def test_augmented_lagrangian_and_active_set_have_one_answer(name: str) -> None:
    answer = solved(name, method="augmented_lagrangian")
    assert_same(answer, by_active_set(name))
    counts = answer.work.counts
    assert counts["Newton steps"] >= counts["multiplier updates"] > counts["steps solved"]
    if name in FAST:  # 6 to 7 updates and 9 to 11 Newton steps; with a penalty of 30 twice as many
        assert counts["multiplier updates"] < 9 * counts["steps solved"]
        assert counts["Newton steps"] < 13 * counts["steps solved"]
    assert "multiplier updates" not in by_active_set(name).work.counts


def layered(stiffness: float, monkeypatch: pytest.MonkeyPatch | None = None):
    """The paper's scene with a layer; by the active set, if it is to be patched."""
    if monkeypatch is not None:
        # the package has a function of the module's name
        module = importlib.import_module("halfplane_fe.solution")
        active_set = partial(module.ContactProblem)

        def problem(*parts, **options):
            return active_set(*parts, **(options | {"method": "active_set"}))

        monkeypatch.setattr(module, "ContactProblem", problem)
    return solved(
        "hertz-paper",
        method="penalty",
        normal_stiffness=stiffness,
        tangential_stiffness=stiffness,
    )


def test_penalty_is_one_return_mapping_and_the_active_set_with_a_layer(monkeypatch) -> None:
    answer = layered(30.0)
    counts = answer.work.counts
    assert counts["Newton steps"] >= counts["steps solved"]
    assert not counts["multiplier updates"]
    reference = layered(30.0, monkeypatch)
    assert "Newton steps" not in reference.work.counts
    for field in ("time", "pressure", "shear", "slip"):
        expected = getattr(reference, field)
        np.testing.assert_allclose(
            getattr(answer, field), expected, rtol=0, atol=1e-10 * np.abs(expected).max()
        )
    assert answer.dissipation == pytest.approx(reference.dissipation, rel=1e-10)


@pytest.mark.slow
def test_penalty_tends_to_the_exact_law_as_one_over_its_stiffness() -> None:
    """Well inside from 10 E*/h on. The largest error is at the edge of contact: below 100 E*/h a
    node more touches there, and the error falls faster (1.3) until it touches no more.
    """
    exact = by_active_set("hertz-paper")
    last = exact.pressure[-1]
    inside = np.abs(exact.x) < 0.7 * exact.contact_half_width[-1]
    stiffnesses = np.array([1e1, 1e2, 1e3, 1e4, 1e6])
    pressures = [layered(float(stiffness)).pressure[-1] for stiffness in stiffnesses]
    errors = np.abs(np.array(pressures) - last)
    orders_inside = -np.diff(np.log(errors[:, inside].max(axis=1))) / np.diff(np.log(stiffnesses))
    np.testing.assert_allclose(orders_inside, 1.0, atol=0.05)
    orders = -np.diff(np.log(errors.max(axis=1))) / np.diff(np.log(stiffnesses))
    np.testing.assert_allclose(orders[1:], 1.0, atol=0.01)
    touching = [int(np.count_nonzero(pressure)) for pressure in pressures]
    assert touching[0] > touching[1] == touching[-1] == np.count_nonzero(last)


def less_shear(pressure, shear, states):
    return pressure, 0.9 * shear, states


def more_shear_in_slip(pressure, shear, states):
    return pressure, np.where(states >= SLIP_FORWARD, 1.01 * shear, shear), states


def less_pressure(pressure, shear, states):
    return 0.99 * pressure, shear, states


@pytest.mark.parametrize("fault", [less_shear, more_shear_in_slip, less_pressure])
@pytest.mark.parametrize(
    "method", [pytest.param("augmented_lagrangian", marks=pytest.mark.slow), "penalty"]
)
def test_wrong_tractions_of_the_return_mapping_are_seen(fault, method, monkeypatch) -> None:
    """The answer moves by far more than both methods may differ, or nothing converges."""
    settings = {"method": method, "steps_per_cycle": 8}
    right = solved("hertz-paper", **settings)
    project = law.project
    monkeypatch.setattr(return_mapping, "project", lambda *trials: fault(*project(*trials)))
    try:
        wrong = solved("hertz-paper", **settings)
    except ConvergenceError:
        return
    limit = 100 * TRACTIONS * right.pressure.max() * right.scene.friction.coefficient
    moved = max(
        np.abs(wrong.pressure[-1] - right.pressure[-1]).max(),
        np.abs(wrong.shear[-1] - right.shear[-1]).max(),
    )
    assert moved > limit


def test_a_penalty_that_never_converges_raises(monkeypatch) -> None:
    monkeypatch.setattr(return_mapping._Iteration, "_inner_loop", lambda *_: None)
    with pytest.raises(ConvergenceError, match="however soft the penalty"):
        solved("hertz-paper", method="penalty")
