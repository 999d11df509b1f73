"""What the page and the terminal say: the question in a sentence, values with their units, the verdict."""

from typing import Any

import numpy as np
import pytest

from reports import compare
from reports.definitions import DEFINITIONS
from reports.units import units
from reports.verdicts import Metric
from reports.wording import question, tolerance_of, unit_of, value_of, verdict
from scenes import Scene, load_scene, scene_names
from test_reports_synthetic import cattaneo_mindlin, with_fields

CYCLE = {"kind": "polygon", "initial_loading": [[2.0, 0.0]], "cycle": [[2.0, 1.0]]}
TRUTH = cattaneo_mindlin(steps_per_leg=10, points=41)


def scene(**changed: Any) -> Scene:
    return Scene.model_validate(load_scene("hertz-paper").model_dump() | changed)


@pytest.mark.parametrize("name", scene_names())
def test_question_of_every_library_scene(name: str) -> None:
    sentence = question(load_scene(name))
    assert "friction coefficient" in sentence
    assert "MPa" in sentence
    assert "N/mm" in sentence
    assert sentence.endswith("?")


def test_question_names_two_materials() -> None:
    material = {part: {"young_modulus": e, "poisson_ratio": 0.3} for part, e in (("upper", 70e3), ("lower", 210e3))}
    assert "upper E = 70000 MPa, ν = 0.3; lower E = 210000 MPa, ν = 0.3" in question(scene(material=material))


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"profile": {"kind": "wedge", "tip_radius": 10.0, "tip_half_length": 0.25}}, "a wedge whose tip of half-length 0.25 mm"),
        (
            {"load": {"kind": "polygon", "initial_loading": [[2.0, 0.0]], "cycle": [[2.0, 1.0]]}},
            "round the straight lines through (2, 0), (2, 1)",
        ),
        ({"load": {"kind": "polygon", "initial_loading": [[2.0, 0.0]]}}, "along the straight lines through (0, 0), (2, 0) N/mm"),
        ({"load": {"kind": "polygon", "initial_loading": [[2.0, 0.0]]}}, "what does the path dissipate?"),
        ({"load": {"kind": "polygon", "initial_loading": [[2.0, 0.0]], "cycle": [[2.0, 1.0]]}}, "what does a cycle dissipate?"),
        ({"load": {"kind": "time_series", "rows": [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]]}}, "what does the path dissipate?"),
        ({"units": "lbf, in, psi"}, "E = 210000 psi"),
        ({"units": "SI"}, "force/length"),
    ],
)
def test_question_has_the_scene_s_own_words(changed: dict[str, Any], words: str) -> None:
    assert words in question(scene(**changed))


def test_units_that_are_no_list_of_three_stay_general() -> None:
    assert units(scene(units="SI")) == ("force", "length", "stress")


def test_values_with_sign_unit_and_elements() -> None:
    edges = TRUTH.stick_edges + np.array([0.0, -0.01])
    found = compare(TRUTH, with_fields(TRUTH, stick_edges=edges, settings={"element_size": 0.02}))
    edge, norm = found.metric("stick_edge"), found.metric("pressure")
    assert (value_of(edge), unit_of(edge), tolerance_of(edge)) == ("−1 %", "of a_ref (−0.5 elements)", "2.5 %")
    assert (value_of(norm), unit_of(norm)) == ("0 %", "of ‖p_ref‖")


def test_absolute_values_are_not_in_per_cent() -> None:
    still = with_fields(TRUTH, dissipation=0.0)
    metric = compare(still, with_fields(TRUTH, dissipation=0.01)).metric("dissipation")
    assert "%" not in value_of(metric) + tolerance_of(metric)
    assert unit_of(metric) == "A f² P_ref²"


@pytest.mark.parametrize(("value", "text"), [(1.87e-16, "0 %"), (-9e-14, "0 %"), (-2e-13, "−2e−11 %"), (1e-5, "+0.001 %")])
def test_rounding_is_told_as_nothing_and_what_is_more_as_it_is(value: float, text: str) -> None:
    assert value_of(Metric(DEFINITIONS["dissipation_step"], value)) == text
    absolute = value_of(Metric(DEFINITIONS["dissipation_step"], value, absolute=True))
    assert (absolute == "0") == (text == "0 %")


def test_verdict_says_what_failed_and_by_how_much() -> None:
    good = verdict(compare(TRUTH, TRUTH))
    assert "within all 6 tolerances" in good
    assert "Both answers are admissible." in good
    bad = verdict(compare(TRUTH, with_fields(TRUTH, pressure=0.99 * TRUTH.pressure)))
    assert "peak pressure (−1 % of peak p_ref, tolerance 0.02 %)" in bad
    assert "pressure, L2 (1 % of ‖p_ref‖, tolerance 0.25 %)" in bad
    assert "A law of contact is violated: cone (fields) in closed form" in bad
