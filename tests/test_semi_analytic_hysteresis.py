"""Stiffness and damping: tangents against differences of the solution, the ratio against its definition, what is refused."""

import math

import numpy as np
import pytest

from scenes import InputError, load_scene
from semi_analytic import compliance, hysteresis, solve
from semi_analytic_cases import ellipse, make_scene


def test_tangent_compliance_is_the_slope_of_the_loop_at_constant_load():
    """Central differences over 2e-4 of a leg, in slip and right after both reversals; second order: 1e-7."""
    scene = load_scene("cattaneo-mindlin")
    middle = np.array([1.5, 2.5, 3.7])
    for time, direction in zip(middle, (1, -1, 1), strict=True):
        near = solve(scene, x=[0.0], time=[time - 1e-4, time, time + 1e-4])
        slope = np.diff(near.tangential_displacement[[0, 2]]) / np.diff(near.tangential_load[[0, 2]])
        assert slope[0] == pytest.approx(compliance(near)[0][1], rel=1e-6)
        assert np.sign(np.diff(near.tangential_load)[0]) == direction


def test_stick_compliance_is_the_slope_right_after_a_reversal():
    scene = load_scene("cattaneo-mindlin")
    near = solve(scene, x=[0.0], time=[2.0, 2.0 + 1e-6])
    slope = np.diff(near.tangential_displacement) / np.diff(near.tangential_load)
    assert slope[0] == pytest.approx(compliance(near)[1][0], rel=1e-5)


def test_damping_ratio_is_that_of_the_linear_oscillator():
    solution = solve(load_scene("hertz-paper"), x=[0.0])
    loop = hysteresis(solution)
    assert loop.damping_ratio == pytest.approx(solution.dissipation / (2 * math.pi * loop.force_amplitude * loop.shift_amplitude))
    assert loop.force_amplitude == pytest.approx(solution.scene.load.tangential_amplitude, rel=1e-12)
    assert loop.secant_stiffness * loop.shift_amplitude == pytest.approx(loop.force_amplitude)
    assert 0.001 < loop.damping_ratio < 0.1


def test_full_stick_is_not_damped():
    assert hysteresis(solve(load_scene("full-stick"), x=[0.0])).damping_ratio == 0


def test_a_loop_that_is_not_there_is_refused():
    with pytest.raises(InputError, match="ask for the fields"):
        hysteresis(solve(load_scene("hertz-paper"), fields=("dissipation",)))
    with pytest.raises(InputError, match="no whole cycle"):
        hysteresis(solve(load_scene("cattaneo-mindlin"), x=[0.0], time=[1.0, 2.0]))
    with pytest.raises(InputError, match="no loop"):
        hysteresis(solve(make_scene(ellipse(3.0, 1.0, 0.0, 0.0), 0.5), x=[0.0]))
