"""The step's own error: end-of-step work less trapezoidal, of interface and loads, is of first order; the balance is closed.

Few elements, so that touches and releases, which are increments of their own, do not hide the order.
"""

import functools
import itertools
from dataclasses import replace

import numpy as np
import pytest

from halfplane_fe import SolverSettings
from problems import COARSE, fe_run
from scenes import EllipseLoad, load_scene
from tolerances import check, check_order

STEPS = (48, 96, 192, 384)
MESH = replace(COARSE, element_size=1 / 8, edge_element_size=1 / 8)
METHODS = ("augmented_lagrangian", "penalty")


@functools.cache
def run(method, steps):
    load = EllipseLoad(mean_normal_load=90, normal_amplitude=30, tangential_amplitude=25, phase_degrees=90)
    update = {"load": load, "cycles": 2, "friction": load_scene("cattaneo-mindlin").friction}
    scene = load_scene("hertz-paper").vary(**update)
    settings = SolverSettings(
        method=method, normal_stiffness=10, tangential_stiffness=10, steps_per_cycle=steps, step_tolerance=np.inf
    )
    return fe_run(scene, MESH, settings)


def excess(method, steps, late, mean):
    """Late less mean work of the last cycle, over its dissipation."""
    answer = run(method, steps)
    cycle, energy = answer.last_cycle[1:], answer.record.energy
    return float(abs((energy[late] - energy[mean])[cycle].sum()) / answer.dissipation)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("late", "mean"), [("end_of_step", "interface"), ("external_end_of_step", "external")])
def test_end_of_step_work_less_trapezoidal_is_of_first_order(method, late, mean):
    check_order(f"{late} work", [1 / n for n in STEPS], [excess(method, n, late, mean) for n in STEPS])


def test_an_excess_of_second_order_would_fail_that_test():
    """What the solver itself goes by, friction work with the mean pressure: its own error falls twice as fast."""
    errors = [float(np.abs(run("augmented_lagrangian", n).record.energy["step_error"]).sum()) for n in STEPS]
    with pytest.raises(AssertionError, match="end_of_step work: order"):
        check_order("end_of_step work", [1 / n for n in STEPS], errors)


def test_the_normal_part_is_there_and_none_of_it_on_the_interface():
    """P d(delta) late costs as soon as P varies; -p dg is zero in each increment, because touches and releases are landed on."""
    answer = run("augmented_lagrangian", 96)
    energy, states = answer.record.energy, answer.states
    P, Q, delta, shift = (
        np.array([getattr(s, name) for s in states]) for name in ("normal_load", "tangential_load", "approach", "shift")
    )
    unit = answer.scales.load**2 / answer.scales.modulus
    normal, tangential = np.diff(P) * np.diff(delta) / 2 * unit, np.diff(Q) * np.diff(shift) / 2 * unit
    late = (energy["external_end_of_step"] - energy["external"])[1:]
    np.testing.assert_allclose(late, normal + tangential, atol=1e-12 * np.abs(late).max())
    assert np.abs(normal).sum() > 0.1 * np.abs(late).sum()
    on_interface = [float((a.pressure - b.pressure) @ (a.gap - b.gap)) for b, a in itertools.pairwise(states)]
    assert np.abs(on_interface).max() < 1e-12


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("steps", [24, 192])
def test_balance_is_closed_at_every_step_however_long(method, steps):
    """External work = elastic energy, that of the layer in it, + trapezoidal work of the interface."""
    answer = run(method, steps)
    energy = answer.record.energy
    rest = energy["external"] - energy["elastic"] - energy["interface"]
    check("certificates", float(np.abs(rest).max() / np.abs(np.cumsum(energy["external"])).max()))
    assert ("layer" in energy) == (method == "penalty")


def test_energy_of_the_layer_is_that_of_its_springs_and_belongs_to_the_balance():
    answer = run("penalty", 24)
    audit, weights = answer.penalty, answer.condensed[0].weights
    stored = (answer.pressure**2 / audit.normal_stiffness + answer.shear**2 / audit.tangential_stiffness) @ weights / 2
    np.testing.assert_allclose(np.cumsum(answer.record.energy["layer"]), stored, atol=1e-12 * stored.max())
    energy = answer.record.energy
    without = energy["external"] - (energy["elastic"] - energy["layer"]) - energy["interface"]
    assert np.abs(without).max() > 1e-5 * np.abs(np.cumsum(energy["external"])).max()
