"""What the rows of a result show before a cause is looked for, each step with its number, and
nodes that alternate.
"""

from __future__ import annotations

import numpy as np
import pytest

import semi_analytic
from reports.report import Report
from reports.scoring.against import score
from reports.scoring.evidence import evidence_steps
from scenes import load_scene

CATTANEO = load_scene("cattaneo-mindlin")
X = np.linspace(-1.2, 1.2, 97)
PATH = CATTANEO.load.path()
TIME = PATH.cycle_start + PATH.period * (2 + np.array([0.25, 0.35, 0.7]))
THEORY = semi_analytic.solve(CATTANEO, x=X, time=TIME, fields=("pressure", "shear"))
CORNERS = np.where(np.arange(len(X)) % 2, 4 / 3, 2 / 3)


def steps_of(pressure: np.ndarray, shear: np.ndarray) -> dict[str, str]:
    comparison = score(X, pressure, shear, scene=CATTANEO, time=TIME).comparison
    return {step.name: step.words for step in evidence_steps(comparison)}


def test_each_step_states_its_number() -> None:
    steps = steps_of(1.1 * THEORY.pressure, 1.5 * THEORY.shear)
    assert list(steps) == ["What was read", "Equilibrium", "Resolution", "Laws", "Shape"]
    assert "97 points from x = −1.2 to 1.2 and 3 instants" in steps["What was read"]
    assert "the sum of p is 1.098 P" in steps["Equilibrium"]
    assert "no load, thickness or unit" not in steps["Equilibrium"]
    assert "79 points in contact" in steps["Resolution"]
    assert "40 spacings over a_ref" in steps["Resolution"]
    assert "violated" in steps["Laws"]
    assert "peak of p 1.1 times the reference's; width by second moments 1 times" in steps["Shape"]


@pytest.fixture(scope="module")
def alternating() -> Report:
    return score(X, CORNERS * THEORY.pressure, CORNERS * THEORY.shear, scene=CATTANEO, time=TIME)


def test_pressures_of_corner_and_mid_side_nodes_are_no_matter_of_loads(
    alternating: Report,
) -> None:
    assert [diagnosis.fault for diagnosis in alternating.diagnoses] == ["alternating"]
    assert "corner and mid-side nodes" in alternating.first_sentence
