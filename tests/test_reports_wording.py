"""What the page and the terminal say: the question in a sentence, values with their units, the verdict."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from reports import Report, compare
from reports.comparison.metrics import METRICS, Metric
from reports.comparison.words import (
    first_table,
    headline,
    lead,
    question,
    tolerance_of,
    unit_of,
    value_of,
    verdict,
    with_uncertainty,
)
from reports.units import units
from scenes import InputError, Scene, load_scene, scene_names
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
    assert value_of(Metric(definition=METRICS["dissipation_step"], value=value)) == text
    absolute = value_of(Metric(definition=METRICS["dissipation_step"], value=value, absolute=True))
    assert (absolute == "0") == (text == "0 %")


def test_verdict_says_what_failed_and_by_how_much() -> None:
    good = verdict(Report(compare(TRUTH, TRUTH)))
    assert "within all 8 tolerances" in good
    assert "Both answers obey the laws of contact." in good
    bad = verdict(Report(compare(TRUTH, with_fields(TRUTH, pressure=0.99 * TRUTH.pressure))))
    assert "peak pressure (−1 % of the reference, tolerance 0.02 %)" in bad
    assert "pressure, L2 (1 % of ‖p_ref‖, tolerance 0.25 %)" in bad
    assert "A law of contact is violated: cone (fields) in closed form" in bad


def bodies(work: float, pressure: float = 1.0, uncertainty: float | None = None, **tolerances: float) -> Report:
    """Finite elements of two blocks against theory, W and p other by these factors, as if a budget had found `uncertainty`."""
    blocks = TRUTH.scene.vary(bodies=load_scene("blocks").bodies, tolerances={})
    theory = with_fields(TRUTH, scene=blocks, engine="semi_analytic")
    changed = {"dissipation": work * TRUTH.dissipation, "pressure": pressure * TRUTH.pressure}
    found = compare(theory, with_fields(theory, engine="halfplane_fe", **changed), tolerances=tolerances)
    return Report(replace(found, metrics=tuple(replace(metric, uncertainty=uncertainty) for metric in found.metrics)))


def test_the_headline_says_how_wrong_theory_is() -> None:
    """W of the finite elements 2 % low: theory is 1/0.98 - 1 = 2.04 % high; digits follow the uncertainty."""
    assert headline(bodies(0.98, 1.005, 6e-4)) == (
        "Half-plane theory overestimates the dissipation by 2.04 ± 0.06 % and underestimates the peak pressure by 0.50 ± 0.06 % "
        "for these bodies (theory/finite elements − 1)."
    )
    assert "gives the dissipation to within its uncertainty (0.01 ± 0.06 %)" in headline(bodies(0.9999, 1.005, 6e-4))
    assert "by 2.04 %" in headline(bodies(0.98))
    assert "no uncertainty was measured" in headline(bodies(0.98))


def test_the_headline_of_half_planes_says_how_far_both_agree() -> None:
    theory = with_fields(TRUTH, engine="semi_analytic")
    near = with_fields(theory, engine="halfplane_fe", dissipation=1.0004 * TRUTH.dissipation)
    agree = "The two solutions agree to 0.04 % in the dissipation and 0 % in the peak pressure; no uncertainty was measured."
    assert headline(Report(compare(theory, near))) == agree
    other = with_fields(theory, engine="another code", dissipation=1.02 * TRUTH.dissipation)
    assert headline(Report(compare(theory, other))).startswith(
        "another code, measured by half-plane theory, overestimates the dissipation by 2 % and"
    )


def test_bodies_without_a_tolerance_are_not_judged() -> None:
    """Errors with uncertainties, no verdict, passed; a tolerance that is asked for judges them."""
    free = bodies(0.98, 1.0, 6e-4)
    assert (free.comparison.verdict, free.passed, lead(free)) == (None, True, "")
    assert "nothing is judged" in verdict(free)
    asked = bodies(0.98, 1.0, 6e-4, dissipation=0.05)
    assert (asked.comparison.verdict, asked.passed) == ("within", True)
    assert bodies(0.98, 1.0, 6e-4, dissipation=0.01).comparison.verdict == "outside"
    assert bodies(0.98, 1.0, 6e-4, dissipation=0.02).comparison.verdict == "undecided"
    with pytest.raises(InputError, match="tolerances: 'disipation' is no metric"):
        bodies(0.98, disipation=0.01)


def test_the_first_table_has_both_values_in_the_scene_s_units() -> None:
    heads, rows = first_table(bodies(0.98, 1.005, 6e-4))
    assert heads == ("", "theory", "finite elements", "difference", "verdict")
    table = {row["key"]: row for row in rows}
    work = table["dissipation"]
    assert work["label"] == "Dissipation [N·mm/mm]"
    assert float(work["result"].replace("−", "-")) == pytest.approx(0.98 * TRUTH.dissipation, rel=1e-4)
    assert (work["difference"], work["verdict"]) == ("−2.00 ± 0.06 %", "–")
    assert float(table["largest_pressure"]["reference"]) == pytest.approx(TRUTH.pressure.max(), rel=1e-4)
    assert table["permanent_stick"]["difference"].endswith(" of a")
    assert table["largest_slip"]["label"] == "Largest slip [µm]"
    text = bodies(0.98, 1.005, 6e-4).summary()
    assert text.startswith("Half-plane theory overestimates")
    assert all(row["difference"] in text for row in rows)


@pytest.mark.parametrize(
    ("value", "doubt", "words"),
    [(2.8512, 0.0614, "2.85 ± 0.06"), (0.5, 0.0113, "0.500 ± 0.011"), (12.0, 35.2, "12 ± 35"), (1e-9, 2e-9, "1e−09 ± 2e−09")],
)
def test_digits_follow_the_uncertainty(value: float, doubt: float, words: str) -> None:
    assert with_uncertainty(value, doubt) == words
