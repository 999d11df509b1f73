"""Scoring of results that are exact but for one planted fault: each is read, matched, judged and named for what it is."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import reports
import semi_analytic
from reports.comparison.metrics import missing
from reports.scoring.against import score_file
from reports.scoring.diagnosis_hypothesis import Hypothesis
from reports.scoring.diagnosis_words import sentence_of
from reports.scoring.mapping import Mapping
from scenes import InputError, load_scene
from score_results import X, exact, rows, written

# Rounding of a comparison of one answer with itself; through a history found from loads or integrals, what these leave (measured
# below each: 5e-9 and 4e-6 of the peak).
SAME, BY_LOADS, BY_INTEGRALS = 1e-12, 1e-7, 5e-5
SCENES = ["hertz-paper", "flat-rounded-paper", "cattaneo-mindlin", "full-stick", "hertz-normal"]


def _score(solution, scene=None, **known):
    arrays = (solution.x, known.pop("p", solution.pressure), known.pop("q", solution.shear))
    return reports.score(*arrays, scene=scene or solution.scene, **known)


@pytest.mark.parametrize("name", SCENES)
def test_an_exact_result_scores_nothing(name):
    solution = exact(name)
    found = _score(solution, time=solution.time, slip=solution.slip)
    assert found.passed
    assert found.diagnoses == ()
    assert found.guesses == ()
    for metric in found.comparison.metrics:
        if metric.value is not None and metric.key not in ("resultant_normal", "resultant_tangential"):
            assert abs(metric.value) < SAME, metric.key


@pytest.fixture
def undiagnosed(monkeypatch):
    """Metrics and sentences alone: the diagnosis has tests of its own (test_reports_score_diagnosis.py)."""
    monkeypatch.setattr("reports.scoring.against.diagnosed", lambda comparison: comparison)


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize("name", ["hertz-paper", "cattaneo-mindlin"])
def test_a_disturbed_result_scores_as_compare_does(name):
    """The metrics of the tractions owe nothing to how the result came in."""
    solution = exact(name)
    disturbed = replace(solution, pressure=1.013 * solution.pressure, shear=0.98 * solution.shear, engine="disturbed")
    ours = reports.compare(exact(name), disturbed)
    theirs = _score(solution, p=disturbed.pressure, q=disturbed.shear, time=solution.time, slip=solution.slip)
    for key in ("peak_pressure", "pressure", "shear", "pressure_maximum", "shear_maximum", "peak_shear", "slip"):
        assert theirs.metric(key).value == pytest.approx(ours.metric(key).value, rel=1e-12, abs=1e-15), key


@pytest.mark.parametrize("name", ["hertz-paper", "flat-rounded-paper", "hertz-normal"])
@pytest.mark.parametrize("by", ["loads", "integrals"])
def test_the_history_is_found_without_times(name, by):
    solution = exact(name)
    loads = {"loads": (solution.normal_load, solution.tangential_load)} if by == "loads" else {}
    found = _score(solution, **loads)
    assert found.passed
    assert abs(found.metric("peak_pressure").value) < (BY_LOADS if by == "loads" else BY_INTEGRALS)
    assert any("matched to the load path" in note for note in found.comparison.notes)


def test_a_result_with_the_initial_loading_is_matched_from_the_start():
    """The first cycle is not the steady one; only the initial loading tells them apart."""
    scene = load_scene("hertz-paper")
    path = scene.load.path()
    time = np.concatenate(
        [np.linspace(path.start, path.cycle_start, 6)[1:], path.cycle_start + np.linspace(0, path.period, 25)[1:]]
    )
    solution = semi_analytic.solve(scene, x=X, time=time)
    found = _score(solution, loads=(solution.normal_load, solution.tangential_load))
    # The square of a distance is flat to 1e-16, its place known to 1e-8 of a cycle.
    np.testing.assert_allclose(found.comparison.result.time, time, atol=1e-6)
    assert found.passed
    assert abs(found.metric("shear").value) < 1e-6


@pytest.mark.usefixtures("undiagnosed")
def test_one_instant_alone_is_scored_and_the_rest_said_to_be_missing():
    solution = exact("hertz-paper")
    one = _score(solution, p=solution.pressure[7], q=1.1 * solution.shear[7], time=solution.time[7])
    assert one.metric("pressure").value < SAME
    assert one.metric("shear").value == pytest.approx(
        0.1 * np.sqrt(np.trapezoid(solution.shear[7] ** 2, X) / np.trapezoid(solution.pressure[7] ** 2, X)), rel=1e-9
    )
    for key in (
        "dissipation",
        "dissipation_density",
        "slip",
        "tangential_displacement",
        "hysteresis",
        "permanent_stick",
        "slip_reversal",
    ):
        assert one.metric(key).value is None, key
        assert "not in the result" in one.metric(key).note, key
    whole = _score(solution, time=solution.time)
    # a(P0) = 1 mm by the choice of the loads; linear between theory's own 905 instants.
    assert one.comparison.scales == whole.comparison.scales
    assert one.comparison.scales.half_width == pytest.approx(1.0, rel=1e-6)


def test_part_of_a_cycle_is_scored():
    solution = exact("hertz-paper")
    part = slice(3, 12)
    found = _score(solution, p=solution.pressure[part], q=solution.shear[part], slip=solution.slip[part], time=solution.time[part])
    assert found.metric("slip").value < SAME
    assert found.metric("dissipation").value is None
    assert "it takes a whole cycle" in found.metric("dissipation").note
    assert found.passed


def test_what_is_missing_is_neither_zero_nor_derived():
    solution = exact("hertz-paper")
    without = _score(solution, time=solution.time)
    assert set(missing(without.comparison.result)) == {"tangential_displacement", "slip", "dissipation", "dissipation_density"}
    assert np.isnan(without.comparison.result.slip).all()
    assert np.isnan(without.comparison.result.dissipation)
    assert without.metric("slip").note == "slip: not in the result (the arrays)"
    assert without.metric("dissipation").note == "dissipation: not in the result; it takes slip (the arrays)"
    assert without.passed


def test_dissipation_from_the_results_own_slip_is_that_of_its_shear():
    """q ds: slip 3 % too large is dissipation 3 % too large, by the rule whose own error is stated."""
    solution = exact("hertz-paper", 97)
    found = _score(solution, time=solution.time, slip=1.03 * solution.slip)
    assert found.metric("dissipation").value == pytest.approx(0.03, abs=1e-9)
    # Of 97 instants and 105 points the rule itself: -1.62e-3 of the engine's own figure.
    assert found.comparison.result.dissipation / 1.03 == pytest.approx(solution.dissipation, rel=2e-3)
    assert any("Dissipation is compared by one rule" in note for note in found.comparison.notes)
    assert found.comparison.reference.dissipation == solution.dissipation


def test_few_instants_of_a_cycle_give_no_dissipation():
    solution = exact("hertz-paper", 6)
    found = _score(solution, time=solution.time, slip=solution.slip)
    assert found.metric("dissipation").value is None
    assert "too coarse" in found.metric("dissipation").note


FACTORS = {
    "x in m": ({"x": 1e-3}, "x multiplied by 1000, for the contact's half-width is 0.00"),
    "x in um": ({"x": 1e3}, "x multiplied by 0.001"),
    "Pa": ({"p": 1e6, "q": 1e6}, "pressure and shear multiplied by 1e-06, for the largest pressure is"),
    "GPa": ({"p": 1e-3, "q": 1e-3}, "pressure and shear multiplied by 1000"),
    "N/m": ({"P": 1e3, "Q": 1e3}, "P and Q multiplied by 0.001, for the largest P is"),
    "m and Pa": ({"x": 1e-3, "p": 1e6, "q": 1e6}, "x multiplied by 1000"),
}


@pytest.mark.parametrize("case", FACTORS)
def test_a_factor_of_units_is_guessed_and_named(case):
    by, words = FACTORS[case]
    solution = exact("hertz-paper")
    loads = (by.get("P", 1) * solution.normal_load, by.get("Q", 1) * solution.tangential_load)
    found = reports.score(
        by.get("x", 1) * X, by.get("p", 1) * solution.pressure, by.get("q", 1) * solution.shear, scene=solution.scene, loads=loads
    )
    assert any(sentence.startswith(words) for sentence in found.guesses)
    assert len(found.guesses) == len({*by} & {"x", "p", "P"})
    assert found.passed


def test_what_the_mapping_states_is_not_guessed_at():
    solution = exact("hertz-paper")
    with pytest.raises(InputError, match="the integral of the pressure"):
        _score(
            solution,
            p=1e6 * solution.pressure,
            q=1e6 * solution.shear,
            time=solution.time,
            mapping=Mapping.model_validate({"factors": {"stress": 1.0}}),
        )


def test_a_factor_of_two_is_no_unit_and_is_refused():
    solution = exact("hertz-paper")
    with pytest.raises(InputError, match=re.escape("2 times as much at every instant: a thickness of that size")):
        _score(solution, time=solution.time, loads=(2 * solution.normal_load, 2 * solution.tangential_load))


def test_pressure_counted_negative_is_turned_and_named():
    solution = exact("hertz-paper")
    found = _score(solution, p=-solution.pressure, time=solution.time)
    assert [sentence[:34] for sentence in found.guesses] == ["the pressure is negative throughout"[:34]]
    assert found.passed


@pytest.mark.usefixtures("undiagnosed")
def test_tension_at_some_points_stays_and_is_named():
    solution = exact("hertz-paper")
    pressure = np.where(solution.pressure > 0, solution.pressure, -0.02 * solution.pressure.max())
    found = _score(solution, p=pressure, time=solution.time)
    assert any(sentence.startswith("the pressure is tension at some points") for sentence in found.guesses)
    assert not found.comparison.admissible


def test_shear_on_the_upper_body_is_scored_as_it_is_and_named():
    solution = exact("hertz-paper")
    for known in ({"time": solution.time}, {}):
        found = _score(solution, q=-solution.shear, **known)
        assert any(sentence.startswith("the shear is opposite to Q") for sentence in found.guesses)
        assert found.metric("shear").value > 0.5
        assert found.diagnoses[0].strength > 0.9


def test_the_mapping_turns_shear_of_a_file(tmp_path):
    table = rows(exact())
    table["shear"] *= -1
    path = written(table, tmp_path / "upper.csv")
    mapping = Mapping.model_validate({"signs": {"shear": "on upper"}})
    assert score_file(path, mapping, exact().scene).passed


def test_slip_of_the_wrong_sense_is_named():
    solution = exact("hertz-paper")
    found = _score(solution, slip=-solution.slip, time=solution.time)
    assert any(sentence.startswith("the slip goes against the shear") for sentence in found.guesses)


def test_places_counted_from_elsewhere_are_shifted_and_named():
    solution = exact("hertz-paper")
    found = reports.score(X + 40.0, solution.pressure, solution.shear, scene=solution.scene, time=solution.time)
    assert any(sentence.startswith("x was counted from 40") for sentence in found.guesses)
    assert found.passed


def test_a_history_that_is_not_the_scenes_is_refused_with_both_values():
    solution = exact("hertz-paper")
    loads = (solution.normal_load.copy(), solution.tangential_load.copy())
    loads[1][9] += 30.0
    with pytest.raises(InputError) as caught:
        _score(solution, loads=loads)
    words = str(caught.value)
    assert f"at instant 10 P = {loads[0][9]:.6g} and Q = {loads[1][9]:.6g}" in words
    assert "nearest that the scene's path has, in order, is P =" in words
    with pytest.raises(InputError, match=f"at instant 10, time {solution.time[9]:.6g}, Q is {loads[1][9]:.6g} and the scene's"):
        _score(solution, loads=loads, time=solution.time)


def test_the_order_of_the_instants_matters():
    """Backwards round the ellipse each pair of loads is on the path, and the history is another one."""
    solution = exact("hertz-paper")
    with pytest.raises(InputError, match="its history is not the scene's"):
        _score(solution, loads=(solution.normal_load[::-1], solution.tangential_load[::-1]))


def test_another_scenes_result_is_refused():
    solution = exact("hertz-paper")
    with pytest.raises(InputError, match="its history is not the scene's"):
        _score(solution, scene="cattaneo-mindlin")


def test_times_outside_the_path_or_backwards_are_refused():
    solution = exact("hertz-paper")
    with pytest.raises(InputError, match="outside the scene's path, which goes from"):
        _score(solution, time=solution.time + 1e3)
    with pytest.raises(InputError, match="time does not ascend: instant 2"):
        _score(solution, time=solution.time[::-1])


@pytest.mark.parametrize("times", [np.linspace(0, 1, 25), np.linspace(0, 1, 25) + exact().time])
def test_a_solvers_own_times_are_given_up_for_the_loads_unless_the_mapping_vouches_for_them(times, tmp_path):
    table = rows(exact())
    table["time"] = np.repeat(times, len(X))
    path = written(table, tmp_path / "own-times.csv")
    found = score_file(path, Mapping(), exact().scene)
    assert found.passed
    assert any(sentence.startswith("the file's times can't be those of the scene's path") for sentence in found.guesses)
    with pytest.raises(InputError, match=r"outside the scene's path|its history is not the scene's"):
        score_file(path, Mapping.model_validate({"columns": {"time": "time"}}), exact().scene)


def test_times_printed_to_six_digits_still_hold_a_whole_cycle():
    solution = exact("hertz-paper")
    printed = [float(f"{t:.6g}") for t in solution.time]
    assert printed[0] != solution.time[0]
    found = _score(solution, time=printed, slip=solution.slip)
    assert found.metric("dissipation").value is not None
    assert found.passed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"q": np.zeros(3)}, "shear has the shape"),
        ({"p": np.zeros((25, len(X)))}, "the pressure is zero at every point and instant"),
        ({"p": np.full((25, len(X)), np.nan)}, "pressure is no finite number at instant 1, point 1"),
    ],
)
def test_arrays_that_are_no_result(change, words):
    solution = exact("hertz-paper")
    with pytest.raises(InputError, match=words):
        _score(solution, time=solution.time, **change)


def test_states_and_edges_are_those_of_the_engine_within_what_is_stated():
    """With slip, in 25 instants and 105 points: edges to the stated few thousandths, states of all but some points."""
    for name in ("hertz-paper", "flat-rounded-paper", "cattaneo-mindlin"):
        solution = exact(name, 49)
        found = _score(solution, time=solution.time, slip=solution.slip).comparison.result
        length = np.nanmax(solution.contact_half_width)
        assert np.nanmax(np.abs(found.contact_edges - solution.contact_edges)) < 2e-3 * length, name
        settled = np.isfinite(found.stick_edges[:, 0]) & np.isfinite(solution.stick_edges[:, 0])
        assert np.median(np.abs(found.stick_edges - solution.stick_edges)[settled]) < 5e-3 * length, name
        assert np.mean(found.state != solution.state) < 0.01, name


def test_our_own_solution_is_scored_as_it_is(tmp_path):
    solution = exact("hertz-paper")
    solution.save(tmp_path / "own.nc")
    found = score_file(tmp_path / "own.nc", Mapping(), solution.scene)
    assert found.metric("dissipation").value == 0.0
    assert found.metric("tangential_displacement").value == 0.0
    with pytest.raises(InputError, match="it answers another scene: profile is"):
        score_file(tmp_path / "own.nc", Mapping(), load_scene("flat-rounded-paper"))
    (tmp_path / "other.nc").write_text("no solution", encoding="utf-8")
    with pytest.raises(InputError, match="this is no solution that halfplane wrote"):
        score_file(tmp_path / "other.nc", Mapping(), solution.scene)


def test_theory_is_solved_once_for_the_scales_and_once_for_the_reference(tmp_path, monkeypatch):
    solution = exact("hertz-paper")
    table = written(rows(solution), tmp_path / "table.csv")
    solution.save(tmp_path / "own.nc")
    calls, solve = [], semi_analytic.solve
    monkeypatch.setattr(semi_analytic, "solve", lambda *scene, **known: calls.append(known) or solve(*scene, **known))
    score_file(table, Mapping(), solution.scene)
    assert len(calls) == 2
    calls.clear()
    score_file(tmp_path / "own.nc", Mapping(), solution.scene)  # states everything itself: its scales are its own
    assert len(calls) == 1


def test_the_package_can_be_called_before_and_after_its_parts_are_imported():
    import reports.scoring.mapping

    assert callable(reports.score)
    assert "score" in dir(reports)


def test_the_page_says_a_label_once_and_a_strength_for_what_it_is(tmp_path: Path) -> None:
    """It was "Dissipation: dissipation: not in the result", and "Explains 7 %" of what explains 86.8 % by itself."""
    scene = load_scene("cattaneo-mindlin")
    x = np.linspace(-1.1, 1.1, 45)
    exact = semi_analytic.solve(scene, x=x, time=[1.0, 1.5, 2.0])
    found = reports.score(x, 0.98 * exact.pressure, exact.shear, scene=scene, time=exact.time, code="mine")
    page = reports.write(found, tmp_path / "out").read_text(encoding="utf-8")
    assert "<li>Dissipation: not in the result" in page
    assert "issipation: dissipation:" not in page
    assert "0.98 times what it should be" in page
    assert f"Strength {found.diagnoses[0].strength:.2f} of 1." in page


def test_the_scenes_own_coupling_is_no_fault_of_the_result() -> None:
    """Theory leaves it out; it was told as bodies that are "not the scene's"."""
    found = Hypothesis("coupling", (X, X), {"beta": -0.052})
    assert "not the scene's" in sentence_of(found)
    own = sentence_of(found, own_beta=-0.068)
    assert "the scene's own materials have -0.068" in own
    assert "no fault of the result" in own
