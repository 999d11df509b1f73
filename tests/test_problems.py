"""The table of problems by other means: uniform tractions by quadrature, and `errors` on the truth
and on planted faults.

Its closed forms of Hertz and of Cattaneo and Mindlin are held to the half-plane engine, to 1e-12,
by `test_semi_analytic_fields.py::test_named_problems_have_their_closed_forms`, and the engine to
brute force in more digits.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad

from problems import PROBLEMS, drawn_inwards, errors, pressed_in


@pytest.mark.parametrize("x", [0.0, 0.4, -1.3])
def test_one_body_under_uniform_traction(x):
    b = 1.4
    young = 3.0
    nu = 0.2
    L = 5.0
    down = sum(quad(lambda s: math.log(L / abs(x - s)), *ends)[0] for ends in ((-b, x), (x, b)))
    assert pressed_in(x, b, young, nu, L) == pytest.approx(
        2 * (1 - nu**2) / (math.pi * young) * down, rel=1e-9
    )
    # Strain along the surface under pressure p, plane strain: (1 - nu^2)/E sigma_xx - nu (1 + nu)/E
    # sigma_yy, both -p there.
    strain = -(1 - nu**2) / young + nu * (1 + nu) / young
    assert drawn_inwards(x, young, nu) == pytest.approx(strain * x, rel=1e-14)


NUMBERS = ("contact_half_width", "stick_half_width", "normal_approach", "tangential_displacement")


def test_errors_of_the_truth_itself_are_none_and_each_planted_fault_is_seen_alone_with_its_size():
    problem = PROBLEMS["mindlin, Q largest"]
    x = np.linspace(-1.05, 1.05, 401)
    exact = problem.exact
    truth = {name: np.array([exact[name]]) for name in NUMBERS} | {
        "dissipation": exact["dissipation"]
    }
    truth |= {name: exact[name](x)[None] for name in ("pressure", "shear")}
    sizes = {
        name: float(np.sqrt(np.trapezoid(truth[name][0] ** 2, x))) for name in ("pressure", "shear")
    }
    share = dict.fromkeys(truth, 0.01) | {  # of what each counts over
        "shear": 0.01 * sizes["shear"] / (problem.scene.friction.coefficient * sizes["pressure"]),
        "stick_half_width": 0.01 * exact["stick_half_width"] / exact["contact_half_width"],
        "tangential_displacement": (
            0.01 * exact["tangential_displacement"] / exact["normal_approach"]
        ),
    }

    def found(**changed):
        answer = SimpleNamespace(
            scene=problem.scene, time=np.array([problem.time]), x=x, **(truth | changed)
        )
        return errors(problem, answer)

    nothing = dict.fromkeys((*truth, "peak_pressure"), 0.0)
    assert found() == nothing
    for name, value in truth.items():
        peak = {"peak_pressure": 0.01} if name == "pressure" else {}
        assert found(**{name: 1.01 * value}) == pytest.approx(
            nothing | {name: share[name]} | peak, rel=1e-9
        ), name
