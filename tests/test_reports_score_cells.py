"""Contact on cells: a layer between the faces, bodies that are not alike."""

from __future__ import annotations

import numpy as np
import pytest

from reports.scoring.cells import pressure_on_layer, shear_by_coupling
from scenes import load_scene
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import contact_of

CATTANEO = load_scene("cattaneo-mindlin")
LOAD = 90.0
X = np.linspace(-1.7, 1.7, 341)


def test_without_a_layer_the_pressure_is_that_of_theory_and_with_one_it_is_lower_and_wider() -> (
    None
):
    loads = np.array([LOAD / 3, LOAD])
    theory = contact_of(CATTANEO.profile, CATTANEO.material).pressure(X, loads[:, None])
    bare = pressure_on_layer(CATTANEO, X, loads, 0.0)
    assert np.max(np.abs(bare - theory)) < 0.04 * theory.max()  # half a cell at the edge
    soft = pressure_on_layer(CATTANEO, X, loads, 0.1 / composite_modulus(CATTANEO.material))
    assert np.trapezoid(soft, X) == pytest.approx(loads, rel=2e-3)
    assert soft.max() < 0.97 * theory.max()
    assert np.sum(soft > 0) > np.sum(theory > 0)


def test_coupling_adds_a_shear_that_is_odd_and_turns_with_the_sign_of_beta() -> None:
    loads = np.array([[LOAD / 2, 0.0], [LOAD, 0.0], [LOAD, 0.2 * LOAD]])
    rows = np.array([1, 2])
    shear = shear_by_coupling(CATTANEO, X, loads, rows, 0.2)
    pressed_only = shear[0]
    assert np.abs(pressed_only).max() > 1e-3 * LOAD
    np.testing.assert_allclose(pressed_only, -pressed_only[::-1], atol=1e-9 * LOAD)
    assert np.trapezoid(shear, X) == pytest.approx(0.0, abs=2e-3 * LOAD)
    turned = shear_by_coupling(CATTANEO, X, loads[:2], rows[:1], -0.2)[0]
    np.testing.assert_allclose(turned, -pressed_only, atol=1e-9 * LOAD)
    np.testing.assert_allclose(shear_by_coupling(CATTANEO, X, loads, rows, 0.0), 0.0)
