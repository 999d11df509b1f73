"""Scoring of results that are exact but for one planted fault: each is read, matched, judged and named for what it is."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import halfplane_fe
import reports
import semi_analytic
from meshes import MeshSettings
from problems import COARSE, FEW_STEPS, fe_run
from reports.comparison import Report
from reports.comparison.metrics import missing
from reports.field_output.files import write_fields
from reports.scoring.against import score_file
from reports.scoring.diagnosis import diagnose
from reports.scoring.history import matched
from reports.scoring.mapping import Mapping
from reports.scoring.surface import SurfaceResult
from scenes import Bodies, ContactSolution, InputError, Scene, load_scene
from score_results import X, exact, rows, written

# Rounding of a comparison of one answer with itself; through a history found from loads or integrals, what these leave (measured
# below each: 5e-9 and 4e-6 of the peak).
SAME, BY_LOADS, BY_INTEGRALS = 1e-12, 1e-7, 5e-5
SCENES = ["hertz-paper", "flat-rounded-paper", "cattaneo-mindlin", "full-stick", "hertz-normal"]
HERTZ = exact("hertz-paper")


@pytest.fixture
def undiagnosed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Metrics and sentences alone: the diagnosis has tests of its own (test_reports_score_diagnosis.py)."""
    monkeypatch.setattr("reports.scoring.against.diagnosed", lambda report: report)


def scored(solution: ContactSolution = HERTZ, scene: Scene | str | None = None, x: Any = None, **known: Any) -> Report:
    """The arrays of a solution, unless others are given."""
    p, q = known.pop("p", solution.pressure), known.pop("q", solution.shear)
    mapping = Mapping.model_validate(known.pop("mapping", {}))
    return reports.score(solution.x if x is None else x, p, q, scene=scene or solution.scene, mapping=mapping, **known)


@pytest.mark.parametrize("name", SCENES)
def test_an_exact_result_scores_nothing(name: str) -> None:
    solution = exact(name)
    found = scored(solution, time=solution.time, slip=solution.slip)
    assert (found.passed, found.diagnoses, found.guesses) == (True, (), ())
    for metric in found.comparison.metrics:
        if metric.value is not None and metric.key not in ("resultant_normal", "resultant_tangential"):
            assert abs(metric.value) < SAME, metric.key


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize("name", ["hertz-paper", "cattaneo-mindlin"])
def test_a_disturbed_result_scores_as_compare_does(name: str) -> None:
    """The metrics of the tractions owe nothing to how the result came in."""
    solution = exact(name)
    disturbed = replace(solution, pressure=1.013 * solution.pressure, shear=0.98 * solution.shear, engine="disturbed")
    ours = reports.compare(solution, disturbed)
    theirs = scored(solution, p=disturbed.pressure, q=disturbed.shear, time=solution.time, slip=solution.slip)
    for key in ("peak_pressure", "pressure", "shear", "pressure_maximum", "shear_maximum", "peak_shear", "slip"):
        assert theirs.metric(key).value == pytest.approx(ours.metric(key).value, rel=1e-12, abs=1e-15), key


# ------------------------------------------------------------------------------------------------------ which instant is which
@pytest.mark.parametrize("name", ["hertz-paper", "flat-rounded-paper", "hertz-normal"])
@pytest.mark.parametrize("by", ["loads", "integrals"])
def test_the_history_is_found_without_times(name: str, by: str) -> None:
    solution = exact(name)
    loads = {"loads": (solution.normal_load, solution.tangential_load)} if by == "loads" else {}
    found = scored(solution, **loads)
    assert found.passed
    assert abs(found.metric("peak_pressure").value) < (BY_LOADS if by == "loads" else BY_INTEGRALS)
    assert any("matched to the load path" in note for note in found.comparison.notes)


def _on_path(name: str, time: np.ndarray, noise: float = 0.0) -> np.ndarray:
    """The times that the loads at `time` are matched to."""
    scene = load_scene(name)
    normal, tangential = scene.load.path().at(time)
    draw = noise * np.random.default_rng(len(time)).standard_normal((2, len(time)))
    normal, tangential = normal * (1 + draw[0]), tangential + np.max(normal) * draw[1]
    empty = np.zeros((len(time), 3))
    loads = {"normal_load": normal, "tangential_load": tangential}
    return matched(SurfaceResult("loads.csv", "", np.linspace(-1.0, 1.0, 3), empty, empty, **loads), scene).time


@pytest.mark.parametrize(("count", "noise"), [*product([9, 14, 22, 25, 40, 59], [0.0, 1e-3]), (1000, 0.0)])
@pytest.mark.parametrize("name", ["cattaneo-mindlin", "phase-180"])
def test_instants_stay_on_their_branch_where_the_path_goes_to_and_fro(name: str, count: int, noise: float) -> None:
    """Between equally near places the earliest is taken, and not the one that is next to a sample of the path."""
    scene = load_scene(name)
    path = scene.load.path()
    time = path.cycle_start + path.period * (scene.cycles - 1 + np.linspace(0, 1, count))
    off = np.diff(_on_path(name, time, noise)) - np.diff(time)
    # Next to a turn of the loads, noise of 1e-3 moves an instant by some hundredths of the period; a branch is a third or a half.
    assert np.max(np.abs(off)) < (0.1 if noise else 0.01) * path.period


@pytest.mark.parametrize(("name", "cycles", "count", "within"), [("cattaneo-mindlin", 3, 301, 1e-9), ("hertz-paper", 1, 25, 1e-6)])
def test_initial_loading_and_cycles_come_one_after_the_other(name: str, cycles: int, count: int, within: float) -> None:
    """Of an ellipse the square of a distance is flat to 1e-16, its place known to 1e-8 of a cycle."""
    path = load_scene(name).load.path()
    first = np.linspace(path.start, path.cycle_start, 20)[1:-1]
    time = np.concatenate([first, path.cycle_start + np.linspace(0, cycles * path.period, count)])
    np.testing.assert_allclose(_on_path(name, time), time, atol=within)


def _table(folder: Path, solution: ContactSolution, *, sign: float = 1.0, loads: bool = False) -> Path:
    table = rows(solution).assign(frame=np.repeat(np.arange(len(solution.time)), len(solution.x)))
    table["shear"] *= sign
    return written(table[["frame", "x", "pressure", "shear", *(["P", "Q"] if loads else [])]], folder / "result.csv")


@pytest.mark.usefixtures("undiagnosed")
def test_a_cycle_that_is_its_own_mirror_image_can_not_tell_the_sign_of_the_shear_and_says_so(tmp_path: Path) -> None:
    for name, sign, loads, mapping, told in (
        ("cattaneo-mindlin", 1.0, False, {}, True),
        ("cattaneo-mindlin", -1.0, False, {}, True),  # -q is +q half a period on
        ("cattaneo-mindlin", 1.0, False, {"signs": {"shear": "on lower"}}, False),
        ("cattaneo-mindlin", 1.0, True, {}, False),
        ("hertz-paper", 1.0, False, {}, False),  # Q of the paper's cycle has a mean: turned round it is another path
    ):
        solution = exact(name)
        path = _table(tmp_path, solution, sign=sign, loads=loads)
        found = score_file(path, Mapping.model_validate(mapping), solution.scene)
        words = "the shear acts on the lower body: its instants were found from the shear itself"
        assert found.passed
        assert any(words in sentence for sentence in found.guesses) == told, (name, sign, loads, mapping)


def test_the_first_revolution_is_taken_for_steady_and_told_what_it_is_and_what_would_say_so(tmp_path: Path) -> None:
    scene = load_scene("cattaneo-mindlin")  # (P, 0) at time 1, corners at 2 and 3
    times = np.concatenate([np.linspace(1.0, 2.0, 7), np.linspace(2.0, 3.0, 13)[1:], np.linspace(3.0, 4.5, 13)[1:]])
    path = _table(tmp_path, semi_analytic.solve(scene, x=np.linspace(-1.2, 1.2, 121), time=times), loads=True)
    found = score_file(path, Mapping(), scene)
    assert not found.passed
    first = diagnose(found.comparison)[0]
    assert first.fault == "not_steady"
    assert "state its times on the scene's path (times of a mapping)" in first.sentence
    right = score_file(path, Mapping(times=tuple(times.tolist())), scene)
    assert right.passed
    assert not diagnose(right.comparison)
    assert right.metric("shear").value < 1e-6


LOADS = (HERTZ.normal_load, HERTZ.tangential_load)
BENT = (HERTZ.normal_load, HERTZ.tangential_load + 30.0 * (np.arange(25) == 9))
REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "a factor of two is no unit": (
        {"time": HERTZ.time, "loads": (2 * LOADS[0], 2 * LOADS[1])},
        "2 times as much at every instant: a thickness of that size",
    ),
    "another history": ({"loads": BENT}, f"at instant 10 P = {BENT[0][9]:.6g} and Q = {BENT[1][9]:.6g}"),
    "and the nearest": ({"loads": BENT}, "nearest that the scene's path has, in order, is P ="),
    "another history at its times": (
        {"loads": BENT, "time": HERTZ.time},
        f"at instant 10, time {HERTZ.time[9]:.6g}, Q is {BENT[1][9]:.6g} and the scene's",
    ),
    "backwards": ({"loads": (LOADS[0][::-1], LOADS[1][::-1])}, "its history is not the scene's"),
    "another scene": ({"scene": "cattaneo-mindlin"}, "its history is not the scene's"),
    "times outside": ({"time": HERTZ.time + 1e3}, "outside the scene's path, which goes from"),
    "times backwards": ({"time": HERTZ.time[::-1]}, "time does not ascend: instant 2"),
    "a stated unit that is wrong": (
        {"p": 1e6 * HERTZ.pressure, "q": 1e6 * HERTZ.shear, "time": HERTZ.time, "mapping": {"factors": {"stress": 1.0}}},
        "the integral of the pressure",
    ),
    "a stated sign that is wrong": (
        {"p": -HERTZ.pressure, "mapping": {"signs": {"pressure": "compression positive"}}},
        "no point is in compression: state the other sign, or leave it out",
    ),
    "a shape": ({"q": np.zeros(3), "time": HERTZ.time}, "shear has the shape"),
    "no pressure": ({"p": np.zeros((25, len(X))), "time": HERTZ.time}, "the pressure is zero at every point and instant"),
    "NaN": ({"p": np.full((25, len(X)), np.nan)}, "pressure is no finite number at instant 1, point 1"),
    "beside the contact": (
        {"x": X + 3.0, "time": HERTZ.time, "mapping": {"x_offset": 1e-9}},  # stated, so that no middle is guessed
        "none of its points lies in the contact: they go from x = 1.7 to 4.3",
    ),
    "no contact at that time": (
        {
            "p": 1e-4 * HERTZ.pressure[:1],
            "q": HERTZ.shear[:1],
            "time": [HERTZ.scene.load.path().start],
            "mapping": {"factors": {"stress": 1.0}},
        },
        "where the scene has no contact: state the scene's times of its instants",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_can_not_be_matched_or_judged_is_refused_with_both_values(case: str) -> None:
    known, words = REFUSED[case]
    with pytest.raises(InputError, match=re.escape(words)):
        scored(**known)


@pytest.mark.parametrize("times", [np.linspace(0, 1, 25), np.linspace(0, 1, 25) + HERTZ.time])
def test_a_solvers_own_times_are_given_up_for_the_loads_unless_the_mapping_vouches_for_them(
    times: np.ndarray, tmp_path: Path
) -> None:
    path = written(rows(HERTZ).assign(time=np.repeat(times, len(X))), tmp_path / "own-times.csv")
    found = score_file(path, Mapping(), HERTZ.scene)
    assert found.passed
    assert any(sentence.startswith("the file's times can't be those of the scene's path") for sentence in found.guesses)
    with pytest.raises(InputError, match=r"outside the scene's path|its history is not the scene's"):
        score_file(path, Mapping.model_validate({"columns": {"time": "time"}}), HERTZ.scene)


def test_times_printed_to_six_digits_still_hold_a_whole_cycle() -> None:
    printed = [float(f"{t:.6g}") for t in HERTZ.time]
    assert printed[0] != HERTZ.time[0]
    assert scored(time=printed, slip=HERTZ.slip).metric("dissipation").value is not None


# ------------------------------------------------------------------------------------------------------- what a result lacks
@pytest.mark.usefixtures("undiagnosed")
def test_what_is_missing_is_neither_zero_nor_derived() -> None:
    one = scored(p=HERTZ.pressure[7], q=1.1 * HERTZ.shear[7], time=HERTZ.time[7])
    assert one.metric("pressure").value < SAME
    sizes = [np.trapezoid(field[7] ** 2, X) for field in (HERTZ.shear, HERTZ.pressure)]
    assert one.metric("shear").value == pytest.approx(0.1 * np.sqrt(sizes[0] / sizes[1]), rel=1e-9)
    of_cycle = ("dissipation", "dissipation_density", "hysteresis", "permanent_stick", "slip_reversal")
    for key in (*of_cycle, "slip", "tangential_displacement"):
        assert one.metric(key).value is None, key
        assert "not in the result" in one.metric(key).note, key
    whole = scored(time=HERTZ.time)
    # a(P0) = 1 mm by the choice of the loads; linear between theory's own 905 instants.
    assert one.comparison.scales == whole.comparison.scales
    assert one.comparison.scales.half_width == pytest.approx(1.0, rel=1e-6)
    assert set(missing(whole.comparison.result)) == {"tangential_displacement", "slip", "dissipation", "dissipation_density"}
    assert np.isnan(whole.comparison.result.slip).all()
    assert np.isnan(whole.comparison.result.dissipation)
    assert whole.metric("slip").note == "slip: not in the result (the arrays)"
    assert whole.metric("dissipation").note == "dissipation: not in the result; it takes slip (the arrays)"
    part = {name: values[3:12] for name, values in (("p", HERTZ.pressure), ("q", HERTZ.shear), ("slip", HERTZ.slip))}
    some = scored(time=HERTZ.time[3:12], **part)
    assert some.metric("slip").value < SAME
    assert "it takes a whole cycle" in some.metric("dissipation").note
    few = exact("hertz-paper", 6)
    assert "too coarse" in scored(few, time=few.time, slip=few.slip).metric("dissipation").note


def test_dissipation_from_the_results_own_slip_is_that_of_its_shear() -> None:
    """q ds: slip 3 % too large is dissipation 3 % too large, by the rule whose own error is stated."""
    solution = exact("hertz-paper", 97)
    found = scored(solution, time=solution.time, slip=1.03 * solution.slip)
    assert found.metric("dissipation").value == pytest.approx(0.03, abs=1e-9)
    # Of 97 instants and 105 points the rule itself: -1.62e-3 of the engine's own figure.
    assert found.comparison.result.dissipation / 1.03 == pytest.approx(solution.dissipation, rel=2e-3)
    assert any("Dissipation is compared by one rule" in note for note in found.comparison.notes)
    assert found.comparison.reference.dissipation == solution.dissipation


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize("name", SCENES[:3])
@pytest.mark.parametrize(("with_slip", "off"), [(True, 0.01), (False, 0.02)])  # 0.0144 without, where slip has just turned
def test_states_and_edges_are_those_of_the_engine_within_what_is_stated(name: str, with_slip: bool, off: float) -> None:
    """In 49 instants and 105 points: edges to the stated few thousandths, states of all but some points."""
    solution = exact(name, 49)
    found = scored(solution, time=solution.time, slip=solution.slip if with_slip else None).comparison.result
    length = np.nanmax(solution.contact_half_width)
    assert np.nanmax(np.abs(found.contact_edges - solution.contact_edges)) < 2e-3 * length
    known = np.isfinite(found.stick_edges[:, 0]) & np.isfinite(solution.stick_edges[:, 0])
    assert np.median(np.abs(found.stick_edges - solution.stick_edges)[known]) < 5e-3 * length
    assert np.mean(found.state != solution.state) < off


# --------------------------------------------------------------------------------------------------------- what is guessed
GUESSES: dict[str, tuple[dict[str, float], str]] = {
    "x in m": ({"x": 1e-3}, "x multiplied by 1000, for the contact's half-width is 0.00"),
    "x in um": ({"x": 1e3}, "x multiplied by 0.001"),
    "Pa": ({"p": 1e6, "q": 1e6}, "pressure and shear multiplied by 1e-06, for the largest pressure is"),
    "GPa": ({"p": 1e-3, "q": 1e-3}, "pressure and shear multiplied by 1000"),
    "N/m": ({"P": 1e3, "Q": 1e3}, "P and Q multiplied by 0.001, for the largest P is"),
    "m and Pa": ({"x": 1e-3, "p": 1e6, "q": 1e6}, "x multiplied by 1000"),
    "compression negative": ({"p": -1}, "the pressure is negative throughout"),
    "loads turned": ({"P": -1}, "the normal load is negative throughout"),
}


@pytest.mark.parametrize("case", GUESSES)
def test_a_factor_of_units_or_a_sign_is_guessed_and_named(case: str) -> None:
    by, words = GUESSES[case]
    values = {"x": X, "p": HERTZ.pressure, "q": HERTZ.shear, "P": LOADS[0], "Q": LOADS[1]}
    x, p, q, *loads = (by.get(name, 1) * value for name, value in values.items())
    found = scored(x=x, p=p, q=q, loads=tuple(loads))
    assert any(sentence.startswith(words) for sentence in found.guesses)
    assert len(found.guesses) == len({*by} & {"x", "p", "P"})
    assert found.passed


ODDITIES: dict[str, tuple[dict[str, Any], str, bool]] = {
    "from elsewhere": ({"x": X + 40.0}, "x was counted from 40", True),
    "tension": (
        {"p": np.where(HERTZ.pressure > 0, HERTZ.pressure, -0.02 * HERTZ.pressure.max())},
        "the pressure is tension at",
        False,
    ),
    "upper shear": ({"q": -HERTZ.shear}, "the shear is opposite to Q", False),
    "upper shear without times": ({"q": -HERTZ.shear, "time": None}, "the shear is opposite to Q", False),
    "slip turned": ({"slip": -HERTZ.slip}, "the slip goes against the shear", False),
}


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize("case", ODDITIES)
def test_what_looks_wrong_is_named_and_scored_as_it_is(case: str) -> None:
    known, words, right = ODDITIES[case]
    found = scored(**({"time": HERTZ.time} | known))
    assert any(sentence.startswith(words) for sentence in found.guesses)
    assert (found.passed and found.comparison.admissible) == right


def test_the_mapping_turns_shear_of_a_file(tmp_path: Path) -> None:
    path = _table(tmp_path, HERTZ, sign=-1.0, loads=True)
    assert score_file(path, Mapping.model_validate({"signs": {"shear": "on upper"}}), HERTZ.scene).passed


# ------------------------------------------------------------------------------------------------------------ our own engines
def test_our_own_solution_is_scored_as_it_is_and_theory_solved_no_more_often_than_needed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls, solve = [], semi_analytic.solve
    table = written(rows(HERTZ), tmp_path / "table.csv")
    HERTZ.save(tmp_path / "own.nc")
    monkeypatch.setattr(semi_analytic, "solve", lambda *scene, **known: calls.append(known) or solve(*scene, **known))
    score_file(table, Mapping(), HERTZ.scene)
    assert len(calls) == 2  # once for the scales, once for the reference
    found = score_file(tmp_path / "own.nc", Mapping(), HERTZ.scene)  # states everything itself: its scales are its own
    assert len(calls) == 3
    assert found.metric("dissipation").value == found.metric("tangential_displacement").value == 0.0
    with pytest.raises(InputError, match="it answers another scene: profile is"):
        score_file(tmp_path / "own.nc", Mapping(), load_scene("flat-rounded-paper"))
    (tmp_path / "other.nc").write_text("no solution", encoding="utf-8")
    with pytest.raises(InputError, match="this is no solution that halfplane wrote"):
        score_file(tmp_path / "other.nc", Mapping(), HERTZ.scene)


def digits(values: np.ndarray) -> np.ndarray:
    """As printed in seven digits."""
    return np.array([float(f"{value:.7g}") for value in np.ravel(values)]).reshape(np.shape(values))


# Measured against the run's own score: 1e-7 of the tractions (seven digits); of the edges, which the run knows better than its
# tractions tell, 3e-5 (contact), 4e-4 (stick, with slip) and 1.2e-2 (stick, without); 3e-4 of the dissipation, of which the rule's
# own share is taken off.
@pytest.mark.slow
def test_a_finite_element_result_in_seven_digits_scores_as_the_run_does() -> None:
    scene = load_scene("hertz-paper")
    run = halfplane_fe.solve(scene, mesh=MeshSettings())
    ours = reports.compare(semi_analytic.solve(scene, x=run.x, time=run.time), run)
    arrays = {"x": digits(run.x), "p": digits(run.pressure), "q": digits(run.shear), "time": digits(run.time)}
    for slip, stick in ((digits(run.slip), 2e-3), (None, 0.015)):
        found = scored(run, slip=slip, **arrays)
        assert (found.passed, found.diagnoses, found.guesses) == (True, (), ())
        limits = {"peak_pressure": 1e-6, "pressure": 1e-6, "shear": 1e-6, "contact_edge": 2e-4, "stick_edge": stick}
        for key, limit in (limits | ({} if slip is None else {"dissipation": 1e-3})).items():
            assert found.metric(key).value == pytest.approx(ours.metric(key).value, abs=limit), key


@pytest.fixture(scope="module", params=["half-planes", "blocks"])
def run(request: pytest.FixtureRequest) -> Iterator[Any]:
    scene = load_scene("cattaneo-mindlin")
    if request.param == "blocks":
        block = {"kind": "block", "width": 20.0, "height": 12.0}
        scene = scene.vary(bodies=Bodies.model_validate({"lower": block, "upper": block}))
    return fe_run(scene, COARSE, FEW_STEPS)


@pytest.mark.usefixtures("undiagnosed")
def test_our_own_field_files_come_back_as_they_were_written(tmp_path: Path, run: Any) -> None:
    """Tractions to the last digit, so that theory scores the files as it scores the run, and the run scores them 0."""
    steps = run.last_cycle[:: max(1, len(run.last_cycle) // 5)]
    write_fields(run, halfplane_fe.fields(run, run.time[steps]), tmp_path)
    found = score_file(tmp_path / "fields.pvd", Mapping(), run.scene)
    np.testing.assert_array_equal(found.comparison.result.time, run.time[steps])
    for name in ("pressure", "shear", "slip"):
        np.testing.assert_array_equal(getattr(found.comparison.result, name), getattr(run, name)[steps], err_msg=name)
    np.testing.assert_allclose(found.comparison.result.x, run.x, rtol=0, atol=1e-12)
    assert found.guesses == ()
    for part in ("lower", "upper"):
        assert any(f"{part}_000.vtu has no 'pressure', 'shear': left out" in note for note in found.comparison.notes)
    arrays = scored(run, p=run.pressure[steps], q=run.shear[steps], slip=run.slip[steps], time=run.time[steps])
    for key in ("peak_pressure", "pressure", "shear", "contact_edge", "stick_edge"):
        assert found.metric(key).value == pytest.approx(arrays.metric(key).value, rel=1e-9), key
        assert found.metric(key).value != 0, key


@pytest.mark.usefixtures("undiagnosed")
def test_the_finite_elements_can_be_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load_scene("cattaneo-mindlin")
    coarse = fe_run(scene, COARSE, FEW_STEPS)
    monkeypatch.setattr(halfplane_fe, "solve", lambda scene: coarse)
    steps = coarse.last_cycle[:: max(1, len(coarse.last_cycle) // 5)]
    theory = semi_analytic.solve(scene, x=X, time=coarse.time[steps])
    found = scored(theory, time=theory.time, against="fe")
    assert found.comparison.reference.engine == "halfplane_fe"
    assert any("was interpolated" in note for note in found.comparison.notes)
    assert 1e-4 < found.metric("pressure").value < 0.15  # a coarse mesh and linear interpolation between its nodes
    with pytest.raises(InputError, match=r"none of its points lies in the contact: they go from x = 1\.7 to 4\.3"):
        scored(theory, x=X + 3.0, time=theory.time, against="fe", mapping={"x_offset": 1e-9})


def test_the_package_can_be_called_and_its_page_says_a_label_once_and_a_strength_for_what_it_is(tmp_path: Path) -> None:
    """It was "Dissipation: dissipation: not in the result", and "Explains 7 %" of what explains 86.8 % by itself."""
    assert callable(reports.score)
    assert "score" in dir(reports)
    scene = load_scene("cattaneo-mindlin")
    three = semi_analytic.solve(scene, x=np.linspace(-1.1, 1.1, 45), time=[1.0, 1.5, 2.0])
    found = scored(three, p=0.98 * three.pressure, time=three.time, code="mine")
    page = reports.write(found, tmp_path / "out").read_text(encoding="utf-8")
    assert "<li>Dissipation: not in the result" in page
    assert "issipation: dissipation:" not in page
    assert "0.98 times what it should be" in page
    assert f"Strength {found.diagnoses[0].strength:.2f} of 1." in page
