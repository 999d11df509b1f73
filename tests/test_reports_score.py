"""Scoring: exact results but for one planted fault; folders as mesh studies; the shipped examples;
measured loops.
"""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from collections.abc import Iterator
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import halfplane_fe
import reports
import semi_analytic
from meshes import MeshSettings
from problems import COARSE, FEW_STEPS, fe_run
from refusals import refused_for, require_facts
from reports.cli import main
from reports.comparison.laws import certificates, names_of_derived_fields
from reports.comparison.metrics import reason_by_missing_field
from reports.console import Stages
from reports.field_output.files import write_fields
from reports.report import Report
from reports.scoring import loop_steady_rows
from reports.scoring.against import score_file, score_surface
from reports.scoring.diagnosis import diagnose
from reports.scoring.history import history_of_result
from reports.scoring.loops import MeasuredLoop, score_loop
from reports.scoring.mapping import Mapping
from reports.scoring.mesh_folder import score_folder
from reports.scoring.study import Level, element_size, result_files, study_of_levels
from reports.scoring.surface import SurfaceResult, surface_result
from scene_cases import FOLDER, scene_of
from scenes import Bodies, ContactSolution, InputError, Scene, load_scene
from score_results import X, exact, rows, written

# Rounding of a comparison of one answer with itself; through a history found from loads or
# integrals, what these leave (measured below each: 5e-9 and 4e-6 of the peak).
SAME = 1e-12
BY_LOADS = 1e-7
BY_INTEGRALS = 5e-5
SCENES = ["hertz-paper", "flat-rounded-paper", "cattaneo-mindlin", "full-stick", "hertz-normal"]
HERTZ = exact("hertz-paper")


@pytest.fixture
def undiagnosed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Metrics and sentences alone: the diagnosis has tests of its own
    (test_reports_score_diagnosis.py).
    """
    monkeypatch.setattr("reports.scoring.against.report_with_diagnoses", lambda report: report)


def scored(
    solution: ContactSolution = HERTZ, scene: Scene | str | None = None, x: Any = None, **known: Any
) -> Report:
    """The arrays of a solution, unless others are given."""
    p = known.pop("p", solution.pressure)
    q = known.pop("q", solution.shear)
    mapping = Mapping.model_validate(known.pop("mapping", {}))
    return reports.score(
        solution.x if x is None else x,
        p,
        q,
        scene=scene or solution.scene,
        mapping=mapping,
        **known,
    )


def within(report: Report) -> bool:
    """Whether all that has a value is within its tolerance; a result without slip has none of the
    dissipation.
    """
    return report.comparison.accurate and report.comparison.admissible


@pytest.mark.parametrize("name", SCENES)
def test_an_exact_result_scores_nothing(name: str) -> None:
    solution = exact(name)
    report = scored(solution, time=solution.time, slip=solution.slip)
    assert (report.passed, report.diagnoses, report.guesses) == (True, (), ())
    for metric in report.comparison.metrics:
        if metric.value is not None and metric.key not in (
            "resultant_normal",
            "resultant_tangential",
        ):
            assert abs(metric.value) < SAME, metric.key


# --------------------------------------------------------------------------- which instant is which
@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize(
    ("name", "by"),
    [
        ("hertz-paper", "loads"),
        ("hertz-paper", "integrals"),
        ("flat-rounded-paper", "integrals"),
        ("hertz-normal", "loads"),
    ],
)
def test_the_history_is_found_without_times(name: str, by: str) -> None:
    solution = exact(name)
    loads = {"loads": (solution.normal_load, solution.tangential_load)} if by == "loads" else {}
    report = scored(solution, **loads)
    assert within(report)
    assert abs(report.metric("peak_pressure").value) < (BY_LOADS if by == "loads" else BY_INTEGRALS)
    assert any("matched to the load path" in note for note in report.comparison.notes)


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize(
    ("columns", "note", "derived"),
    [
        (["P"], "Q is the scene's at its instants", {"tangential_load"}),
        (["Q"], "P is the scene's at its instants", {"normal_load"}),
        ([], "P and Q are the scene's at its instants", {"normal_load", "tangential_load"}),
        (["P", "Q"], "", set()),
    ],
)
def test_a_load_that_is_stated_is_kept_and_checked(
    tmp_path: Path, columns: list[str], note: str, derived: set[str]
) -> None:
    """Loads 0.3 % of the largest P too large, where 0.5 % is the same history: the law of the loads
    is checked where one of them is stated.
    """
    table = rows(HERTZ)
    excess = 0.003 * HERTZ.normal_load.max()
    for name in columns:
        table[name] += excess
    path = written(table[["time", "x", "pressure", "shear", *columns]], tmp_path / "result.csv")
    solution = score_file(path, Mapping(), HERTZ.scene).comparison.result
    stated = {"P": "normal_load", "Q": "tangential_load"}
    for name, field in stated.items():
        np.testing.assert_allclose(
            getattr(solution, field) - getattr(HERTZ, field),
            excess if name in columns else 0.0,
            atol=1e-6 * excess,
        )
    assert names_of_derived_fields(solution) & set(stated.values()) == derived
    assert [text for text in solution.record.notes if "the scene's at" in text] == [note] * bool(
        note
    )
    laws = {law.name: law for law in certificates(solution)}
    assert ("loads" in laws) == bool(columns)
    if columns:
        assert laws["loads"].value == pytest.approx(0.003, rel=1e-4)


def test_times_printed_with_nine_digits_break_no_law_of_the_reference() -> None:
    """Theory takes an instant just behind the end of the cycle that it follows as that end."""
    path = HERTZ.scene.load.path()
    time = path.cycle_start + path.period * (1 + np.linspace(0, 1, 41) + 2e-9)
    reference = semi_analytic.solve(HERTZ.scene, x=[0.0], time=time)
    loads = {law.name: law for law in certificates(reference)}["loads"]
    assert 1e-9 < loads.value < 1e-8
    assert loads.holds


def _on_path(name: str, time: np.ndarray, noise: float = 0.0) -> np.ndarray:
    """The times that the loads at `time` are matched to."""
    scene = scene_of(name)
    normal, tangential = scene.load.path().at(time)
    draw = noise * np.random.default_rng(len(time)).standard_normal((2, len(time)))
    normal, tangential = normal * (1 + draw[0]), tangential + np.max(normal) * draw[1]
    empty = np.zeros((len(time), 3))
    loads = {"normal_load": normal, "tangential_load": tangential}
    return history_of_result(
        SurfaceResult("loads.csv", "", np.linspace(-1.0, 1.0, 3), empty, empty, **loads), scene
    ).time


@pytest.mark.parametrize(
    ("count", "noise"), [*product([9, 14, 22, 25, 40, 59], [0.0, 1e-3]), (1000, 0.0)]
)
@pytest.mark.parametrize("name", ["cattaneo-mindlin", "phase-180"])
def test_instants_stay_on_their_branch_where_the_path_goes_to_and_fro(
    name: str, count: int, noise: float
) -> None:
    """Between equally near places the earliest is taken, and not the one that is next to a sample
    of the path.
    """
    scene = scene_of(name)
    path = scene.load.path()
    time = path.cycle_start + path.period * (scene.cycles - 1 + np.linspace(0, 1, count))
    off = np.diff(_on_path(name, time, noise)) - np.diff(time)
    # Next to a turn of the loads, noise of 1e-3 moves an instant by some hundredths of the period;
    # a branch is a third or a half.
    assert np.max(np.abs(off)) < (0.1 if noise else 0.01) * path.period


def _table(
    folder: Path, solution: ContactSolution, *, sign: float = 1.0, loads: bool = False
) -> Path:
    table = rows(solution).assign(frame=np.repeat(np.arange(len(solution.time)), len(solution.x)))
    table["shear"] *= sign
    return written(
        table[["frame", "x", "pressure", "shear", *(["P", "Q"] if loads else [])]],
        folder / "result.csv",
    )


@pytest.mark.usefixtures("undiagnosed")
def test_a_cycle_that_is_its_own_mirror_image_can_not_tell_the_sign_of_the_shear_and_says_so(
    tmp_path: Path,
) -> None:
    for name, sign, loads, mapping, is_named in (
        ("cattaneo-mindlin", 1.0, False, {}, True),
        ("cattaneo-mindlin", -1.0, False, {}, True),  # -q is +q half a period on
        ("cattaneo-mindlin", 1.0, False, {"signs": {"shear": "on lower"}}, False),
        ("cattaneo-mindlin", 1.0, True, {}, False),
        # Q of the paper's cycle has a mean: turned round it is another path
        ("hertz-paper", 1.0, False, {}, False),
    ):
        solution = exact(name)
        path = _table(tmp_path, solution, sign=sign, loads=loads)
        report = score_file(path, Mapping.model_validate(mapping), solution.scene)
        words = "the shear acts on the lower body"
        assert within(report)
        assert any(words in sentence for sentence in report.guesses) == is_named, (
            name,
            sign,
            loads,
            mapping,
        )


def test_the_first_revolution_is_taken_for_steady_and_told_what_it_is_and_what_would_say_so(
    tmp_path: Path,
) -> None:
    scene = load_scene("cattaneo-mindlin")  # (P, 0) at time 1, corners at 2 and 3
    times = np.concatenate(
        [np.linspace(1.0, 2.0, 7), np.linspace(2.0, 3.0, 13)[1:], np.linspace(3.0, 4.5, 13)[1:]]
    )
    path = _table(
        tmp_path, semi_analytic.solve(scene, x=np.linspace(-1.2, 1.2, 121), time=times), loads=True
    )
    report = score_file(path, Mapping(), scene)
    assert not report.passed
    first = diagnose(report.comparison)[0]
    assert first.fault == "not_steady"
    assert "(times of a mapping)" in first.sentence
    right = score_file(path, Mapping(times=tuple(times.tolist())), scene)
    assert within(right)
    assert not diagnose(right.comparison)
    assert right.metric("shear").value < 1e-6


LOADS = (HERTZ.normal_load, HERTZ.tangential_load)
BENT = (HERTZ.normal_load, HERTZ.tangential_load + 30.0 * (np.arange(25) == 9))
REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "a factor of two is no unit": (
        {"time": HERTZ.time, "loads": (2 * LOADS[0], 2 * LOADS[1])},
        "2 times as much at every instant",
    ),
    "another history": (
        {"loads": BENT},
        f"at instant 10 P = {BENT[0][9]:.6g} and Q = {BENT[1][9]:.6g}",
    ),
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
        {
            "p": 1e6 * HERTZ.pressure,
            "q": 1e6 * HERTZ.shear,
            "time": HERTZ.time,
            "mapping": {"factors": {"stress": 1.0}},
        },
        "the integral of the pressure",
    ),
    "a stated sign that is wrong": (
        {"p": -HERTZ.pressure, "mapping": {"signs": {"pressure": "compression positive"}}},
        "no point is in compression",
    ),
    "a shape": ({"q": np.zeros(3), "time": HERTZ.time}, "shear has the shape"),
    "no pressure": (
        {"p": np.zeros((25, len(X))), "time": HERTZ.time},
        "the pressure is zero at every point and instant",
    ),
    "NaN": (
        {"p": np.full((25, len(X)), np.nan)},
        "pressure is no finite number at instant 1, point 1",
    ),
    "beside the contact": (
        # stated, so that no middle is guessed
        {"x": X + 3.0, "time": HERTZ.time, "mapping": {"x_offset": 1e-9}},
        "from x = 1.7 to 4.3",
    ),
    "no contact at that time": (
        {
            "p": 1e-4 * HERTZ.pressure[:1],
            "q": HERTZ.shear[:1],
            "time": [HERTZ.scene.load.path().start],
            "mapping": {"factors": {"stress": 1.0}},
        },
        "where the scene has no contact",
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
    report = score_file(path, Mapping(), HERTZ.scene)
    assert within(report)
    assert any(
        sentence.startswith("the file's times can't be those of the scene's path")
        for sentence in report.guesses
    )
    with pytest.raises(
        InputError, match=r"outside the scene's path|its history is not the scene's"
    ):
        score_file(path, Mapping.model_validate({"columns": {"time": "time"}}), HERTZ.scene)


# ------------------------------------------------------------------------------ what a result lacks
@pytest.mark.usefixtures("undiagnosed")
def test_what_is_missing_is_neither_zero_nor_derived() -> None:
    frame = scored(p=HERTZ.pressure[7], q=1.1 * HERTZ.shear[7], time=HERTZ.time[7])
    assert frame.metric("pressure").value < SAME
    ratio = np.trapezoid(HERTZ.shear[7] ** 2, X) / np.trapezoid(HERTZ.pressure[7] ** 2, X)
    assert frame.metric("shear").value == pytest.approx(0.1 * np.sqrt(ratio), rel=1e-9)
    of_cycle = ("dissipation", "dissipation_density", "hysteresis", "permanent_stick")
    for key in (*of_cycle, "slip", "tangential_displacement"):
        assert frame.metric(key).value is None, key
        assert "not in the result" in frame.metric(key).note, key
    cycle = scored(time=HERTZ.time)
    # a(P0) = 1 mm by the choice of the loads; linear between theory's own 905 instants.
    assert frame.comparison.scales == cycle.comparison.scales
    assert frame.comparison.scales.half_width == pytest.approx(1.0, rel=1e-6)
    lacking = {"tangential_displacement", "slip", "dissipation", "dissipation_density"}
    assert set(reason_by_missing_field(cycle.comparison.result)) == lacking
    assert np.isnan(cycle.comparison.result.slip).all()
    assert np.isnan(cycle.comparison.result.dissipation)
    require_facts(cycle.metric("slip").note, "slip: not in the result")
    require_facts(cycle.metric("dissipation").note, "not in the result", "it takes slip")
    part = slice(3, 12)
    arrays = {"p": HERTZ.pressure[part], "q": HERTZ.shear[part], "slip": HERTZ.slip[part]}
    part_of_cycle = scored(time=HERTZ.time[part], **arrays)
    assert part_of_cycle.metric("slip").value < SAME
    assert "it takes a whole cycle" in part_of_cycle.metric("dissipation").note
    coarse = exact("hertz-paper", 6)
    report = scored(coarse, time=coarse.time, slip=coarse.slip)
    assert "too coarse" in report.metric("dissipation").note


def test_dissipation_from_the_results_own_slip_is_that_of_its_shear() -> None:
    """q ds: slip 3 % too large is dissipation 3 % too large, by the rule whose own error is
    stated.
    """
    solution = exact("hertz-paper", 97)
    report = scored(solution, time=solution.time, slip=1.03 * solution.slip)
    assert report.metric("dissipation").value == pytest.approx(0.03, abs=1e-9)
    # Of 97 instants and 105 points the rule itself: -1.62e-3 of the engine's own figure.
    assert report.comparison.result.dissipation / 1.03 == pytest.approx(
        solution.dissipation, rel=2e-3
    )
    assert any("Dissipation is compared by one rule" in note for note in report.comparison.notes)
    assert report.comparison.reference.dissipation == solution.dissipation


# ---------------------------------------------------------------------------------- what is guessed
GUESSES: dict[str, tuple[dict[str, float], str]] = {
    "x in m": ({"x": 1e-3}, "x multiplied by 1000"),
    "x in um": ({"x": 1e3}, "x multiplied by 0.001"),
    "Pa": (
        {"p": 1e6, "q": 1e6},
        "pressure and shear multiplied by 1e-06",
    ),
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
    report = scored(x=x, p=p, q=q, loads=tuple(loads))
    assert any(sentence.startswith(words) for sentence in report.guesses)
    assert len(report.guesses) == len({*by} & {"x", "p", "P"})
    assert within(report)


ODDITIES: dict[str, tuple[dict[str, Any], str, bool]] = {
    "from elsewhere": ({"x": X + 40.0}, "x was counted from 40", True),
    "tension": (
        {"p": np.where(HERTZ.pressure > 0, HERTZ.pressure, -0.02 * HERTZ.pressure.max())},
        "the pressure is tension at",
        False,
    ),
    "upper shear": ({"q": -HERTZ.shear}, "the shear is opposite to Q", False),
    "upper shear without times": (
        {"q": -HERTZ.shear, "time": None},
        "the shear is opposite to Q",
        False,
    ),
    "slip turned": ({"slip": -HERTZ.slip}, "the slip goes against the shear", False),
}


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize("case", ODDITIES)
def test_what_looks_wrong_is_named_and_scored_as_it_is(case: str) -> None:
    known, words, right = ODDITIES[case]
    report = scored(**({"time": HERTZ.time} | known))
    assert any(sentence.startswith(words) for sentence in report.guesses)
    assert within(report) == right


# ---------------------------------------------------------------------------------- our own engines
def test_our_own_solution_is_scored_as_it_is_and_theory_solved_no_more_often_than_needed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    solve = semi_analytic.solve
    table = written(rows(HERTZ), tmp_path / "table.csv")
    HERTZ.save(tmp_path / "own.nc")
    monkeypatch.setattr(
        semi_analytic,
        "solve",
        lambda *scene, **known: calls.append(known) or solve(*scene, **known),
    )
    score_file(table, Mapping(), HERTZ.scene)
    assert len(calls) == 2  # once for the scales, once for the reference
    # states everything itself: its scales are its own
    report = score_file(tmp_path / "own.nc", Mapping(), HERTZ.scene)
    assert len(calls) == 3
    assert (
        report.metric("dissipation").value == report.metric("tangential_displacement").value == 0.0
    )
    with pytest.raises(InputError, match="it answers another scene: profile is"):
        score_file(tmp_path / "own.nc", Mapping(), load_scene("flat-rounded-paper"))
    (tmp_path / "other.nc").write_text("no solution", encoding="utf-8")
    with pytest.raises(InputError, match="this is no solution that halfplane wrote"):
        score_file(tmp_path / "other.nc", Mapping(), HERTZ.scene)


def digits(values: np.ndarray) -> np.ndarray:
    """As printed in seven digits."""
    return np.array([float(f"{value:.7g}") for value in np.ravel(values)]).reshape(np.shape(values))


# Measured against the run's own score: 1e-7 of the tractions (seven digits); of the edges, which
# the run knows better than its tractions tell, 3e-5 (contact), 4e-4 (stick, with slip) and 1.2e-2
# (stick, without); 3e-4 of the dissipation, of which the rule's own share is taken off.
@pytest.mark.slow
def test_a_finite_element_result_in_seven_digits_scores_as_the_run_does() -> None:
    scene = load_scene("hertz-paper")
    run = halfplane_fe.solve(scene, mesh=MeshSettings())
    ours = reports.compare(semi_analytic.solve(scene, x=run.x, time=run.time), run)
    arrays = {
        "x": digits(run.x),
        "p": digits(run.pressure),
        "q": digits(run.shear),
        "time": digits(run.time),
    }
    for slip, stick in ((digits(run.slip), 2e-3), (None, 0.015)):
        report = scored(run, slip=slip, **arrays)
        # Without slip the scene's tolerance of the dissipation can't be judged.
        unscored = () if slip is not None else ("dissipation",)
        assert tuple(metric.key for metric in report.comparison.unscored) == unscored
        assert (report.passed, report.diagnoses, report.guesses) == (not unscored, (), ())
        limits = {
            "peak_pressure": 1e-6,
            "pressure": 1e-6,
            "shear": 1e-6,
            # The run places its edges by the loads between nodes, which a file does not hold: there
            # the edge is that of a fit to the pressure, 3.2e-4 from theory, ours 1.0e-4.
            "contact_edge": 3e-4,
            "stick_edge": stick,
        }
        for key, limit in (limits | ({} if slip is None else {"dissipation": 1e-3})).items():
            assert report.metric(key).value == pytest.approx(ours.metric(key).value, abs=limit), key


@pytest.fixture(scope="module", params=["half-planes", "blocks"])
def run(request: pytest.FixtureRequest) -> Iterator[Any]:
    scene = load_scene("cattaneo-mindlin")
    if request.param == "blocks":
        block = {"kind": "block", "width": 20.0, "height": 12.0}
        scene = scene.vary(bodies=Bodies.model_validate({"lower": block, "upper": block}))
    return fe_run(scene, COARSE, FEW_STEPS)


@pytest.mark.usefixtures("undiagnosed")
def test_our_own_field_files_come_back_as_they_were_written(tmp_path: Path, run: Any) -> None:
    """Tractions to the last digit, so that theory scores the files as it scores the run, and the
    run scores them 0.
    """
    steps = run.last_cycle[:: max(1, len(run.last_cycle) // 5)]
    write_fields(run, halfplane_fe.fields(run, run.time[steps]), tmp_path)
    report = score_file(tmp_path / "fields.pvd", Mapping(), run.scene)
    np.testing.assert_array_equal(report.comparison.result.time, run.time[steps])
    for name in ("pressure", "shear", "slip"):
        np.testing.assert_array_equal(
            getattr(report.comparison.result, name), getattr(run, name)[steps], err_msg=name
        )
    np.testing.assert_allclose(report.comparison.result.x, run.x, rtol=0, atol=1e-12)
    assert report.guesses == ()
    for part in ("lower", "upper"):
        assert any(
            f"{part}_000.vtu has no 'pressure', 'shear': left out" in note
            for note in report.comparison.notes
        )
    arrays = scored(
        run, p=run.pressure[steps], q=run.shear[steps], slip=run.slip[steps], time=run.time[steps]
    )
    for key in ("peak_pressure", "pressure", "shear", "contact_edge", "stick_edge"):
        assert report.metric(key).value == pytest.approx(arrays.metric(key).value, rel=1e-9), key
        assert report.metric(key).value != 0, key


@pytest.mark.usefixtures("undiagnosed")
def test_the_finite_elements_can_be_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load_scene("cattaneo-mindlin")
    coarse = fe_run(scene, COARSE, FEW_STEPS)
    monkeypatch.setattr(halfplane_fe, "solve", lambda scene: coarse)
    steps = coarse.last_cycle[:: max(1, len(coarse.last_cycle) // 5)]
    theory = semi_analytic.solve(scene, x=X, time=coarse.time[steps])
    report = scored(theory, time=theory.time, against="fe")
    assert report.comparison.reference.engine == "halfplane_fe"
    assert any("was interpolated" in note for note in report.comparison.notes)
    # a coarse mesh and linear interpolation between its nodes
    assert 1e-4 < report.metric("pressure").value < 0.15
    with refused_for("from x = 1.7 to 4.3"):
        scored(theory, x=X + 3.0, time=theory.time, against="fe", mapping={"x_offset": 1e-9})


# ---------------------------------------------------------------------------- folders: mesh studies
POINTS = (27, 53, 105, 209)


def level(
    points: int,
    order: float = 2.0,
    amount: float = 0.3,
    rest: float = 0.0,
    worst: int | None = None,
) -> Level:
    """The exact tractions but for a factor 1 + rest + amount h^order, twice that at the `worst`
    instant.
    """
    solution = exact("hertz-paper", 9, points)
    size = float(np.diff(solution.x)[0])
    factor = 1 + rest + amount * size**order * np.where(np.arange(9) == worst, 2.0, 1.0)[:, None]
    fields = {"pressure": factor * solution.pressure, "shear": factor * solution.shear}
    surface = surface_result(f"run{points}.csv", "", solution.x, fields, {"time": solution.time})
    return Level(
        f"run{points}.csv",
        size,
        "planted",
        score_surface(surface, Mapping(), solution.scene).comparison,
    )


@pytest.mark.parametrize(("order", "amount"), [(2.0, 0.3), (1.0, 0.05), (1.5, 0.2)])
def test_a_planted_order_is_found_and_the_rest_is_left(order: float, amount: float) -> None:
    known = study_of_levels([level(points, order, amount, 2e-3) for points in POINTS])
    for key in ("peak_pressure", "pressure"):
        row = known.row_of_metric(key)
        assert order - 0.02 < row.extrapolation.order < order + 0.02, key
        assert row.extrapolation.value == pytest.approx(2e-3, rel=1e-3), key
        assert abs(row.extrapolation.value - 2e-3) <= row.extrapolation.uncertainty, key
        error = amount * known.levels[0].size ** order
        assert row.error_of_finest_mesh == pytest.approx(error, rel=1e-3), key


def test_the_finest_comes_first_errors_that_grow_have_no_order_and_nor_do_two_meshes() -> None:
    known = study_of_levels([level(points) for points in (105, 27, 53)])
    assert [mesh.name for mesh in known.levels] == ["run105.csv", "run53.csv", "run27.csv"]
    values = known.row_of_metric("peak_pressure").values
    assert values[0] == min(values)
    growing = study_of_levels([level(points, -1.0, 1e-4) for points in POINTS[:3]])
    row = growing.row_of_metric("peak_pressure")
    assert (row.extrapolation.kind, row.error_of_finest_mesh) == ("diverging", None)
    # both where the finest is worst
    of_two = study_of_levels([level(53, worst=2), level(27, worst=6)])
    fine, coarse = of_two.row_of_metric("peak_pressure").values
    assert coarse / fine == pytest.approx(4 / 2)
    two = study_of_levels([level(points) for points in (27, 53)])
    assert two.row_of_metric("peak_pressure").extrapolation.order is None
    assert any("Two meshes show no order" in sentence for sentence in two.sentences)
    for levels, words in (
        ([level(27)], "takes two meshes at least"),
        ([level(27)] * 2, "have the same element size"),
    ):
        with pytest.raises(InputError, match=words):
            study_of_levels(levels)


@pytest.mark.parametrize(
    ("name", "sizes", "size", "how"),
    [
        ("run_h0.5.csv", {}, 0.5, "from the file's name"),
        ("mesh-0.25mm.csv", {}, 0.25, "from the file's name"),
        ("run_h0.5.csv", {"run_h0.5.csv": 0.125}, 0.125, "from the mapping"),
        ("half.csv", {}, 0.1, "median spacing of the points in contact"),
    ],
)
def test_where_the_element_size_is_from(
    tmp_path: Path, name: str, sizes: dict[str, float], size: float, how: str
) -> None:
    assert element_size(tmp_path / name, Mapping(element_sizes=sizes), level(27).comparison) == (
        pytest.approx(size),
        how,
    )


ENTRIES = "".join(f'<DataSet timestep="{k}" file="fine_{k}.vtu"/>' for k in range(3))
COLLECTIONS = {
    "fine.pvd": (
        f'<VTKFile type="Collection" version="0.1"><Collection>{ENTRIES}</Collection></VTKFile>'
    ),
} | dict.fromkeys(("fine_0.vtu", "fine_1.vtu", "fine_2.vtu", "alone.vtu"), "x")
FOLDERS = {
    "one file of each stem": (
        dict.fromkeys(("a.frd", "a.dat", "b.csv", "c.md"), "x"),
        "a.frd b.csv",
        "Left out of the folder: a.dat, c.md.",
    ),
    "collections": (
        COLLECTIONS,
        "alone.vtu fine.pvd",
        "Read through the collections that name them: 3 files.",
    ),
}


@pytest.mark.parametrize("case", FOLDERS)
def test_which_files_of_a_folder_are_results(tmp_path: Path, case: str) -> None:
    """Each instant of a PVD would else be a mesh of its own."""
    with pytest.raises(InputError, match="no result is in this folder"):
        result_files(tmp_path)
    files, names, note = FOLDERS[case]
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    paths, notes = result_files(tmp_path)
    assert [path.name for path in paths] == names.split()
    assert notes == ((note,) if note else ())
    if case == "collections":
        (tmp_path / "fine.pvd").write_text("<VTKFile", encoding="utf-8")
        with pytest.raises(InputError, match=r"fine\.pvd: this can't be read as a \.pvd file"):
            result_files(tmp_path)


def test_what_can_not_be_read_in_a_folder_is_listed_and_the_rest_is_scored(tmp_path: Path) -> None:
    scene = exact().scene
    stages = Stages(quiet=True)
    written(rows(exact()), tmp_path / "run_h0.02.csv")
    (tmp_path / "spoilt_h0.1.csv").write_text("x,pressure,shear\n0,1,oops\n", encoding="utf-8")
    (tmp_path / "junk_h0.2.vtu").write_text("no XML", encoding="utf-8")
    single = score_folder(tmp_path, Mapping(), scene, stages)
    listed = [note for note in single.comparison.notes if note.startswith("Not scored: ")]
    assert single.study is None
    assert single.comparison.result.engine == "run_h0.02.csv"
    require_facts(listed[0], "junk_h0.2.vtu")
    require_facts(listed[1], "spoilt_h0.1.csv", "line 2", "shear = 'oops'")
    assert [file.name for file in single.unscored] == ["junk_h0.2.vtu", "spoilt_h0.1.csv"]
    written(rows(exact(points=53)), tmp_path / "run_h0.04.csv")
    pair = score_folder(tmp_path, Mapping(), scene, stages)
    assert pair.study is not None
    assert [level.name for level in pair.study.levels] == ["run_h0.02.csv", "run_h0.04.csv"]
    assert [note for note in pair.study.notes if note.startswith("Not scored: ")] == listed
    for readable in tmp_path.glob("run*"):
        readable.unlink()
    with refused_for("junk_h0.2.vtu", "1 other files"):
        score_folder(tmp_path, Mapping(), scene, stages)


# ---------------------------------------------------- the scored examples that ship with the manual
EXAMPLE_FOLDER = Path(__file__).parents[1] / "docs" / "examples" / "score"
_SPEC = importlib.util.spec_from_file_location("measure_examples", EXAMPLE_FOLDER / "measure.py")
assert _SPEC is not None
assert _SPEC.loader is not None
measure: Any = importlib.util.module_from_spec(_SPEC)
sys.modules["measure_examples"] = measure
_SPEC.loader.exec_module(measure)

SHIPPED = json.loads((EXAMPLE_FOLDER / "numbers.json").read_text("utf-8"))
EXAMPLES = {example.name: example for example in measure.EXAMPLES}


@cache
def example_scored(name: str) -> Report:
    return measure.scored(EXAMPLES[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_scores_what_it_and_its_page_say(name: str) -> None:
    """Where a rule of the score was changed on purpose: python docs/examples/score/measure.py."""
    numbers = measure.numbers(example_scored(name))
    shipped = SHIPPED[name]
    assert (numbers["diagnoses"], numbers["passed"]) == (shipped["diagnoses"], shipped["passed"])
    for key, value in shipped["metrics"].items():
        assert numbers["metrics"][key] == (
            value if value is None else pytest.approx(value, rel=1e-6, abs=1e-12)
        ), key
    stored = json.loads((EXAMPLE_FOLDER / name / "made.json").read_text("utf-8"))
    block = measure.MARKS.search((EXAMPLE_FOLDER / name / "README.md").read_text("utf-8"))
    assert block is not None
    assert block[0] == measure.block_of(example_scored(name), stored)
    assert sum(file.stat().st_size for file in (EXAMPLE_FOLDER / name).iterdir()) < 1_000_000


# ----------------------------------------------------------------- a measured loop as the reference
CONSTANT = load_scene("cattaneo-mindlin")
PAPER = load_scene("hertz-paper")
LOOP_LOAD = CONSTANT.load.cycle[0][0]
# Q to 0.95 of gross sliding, where the loop is wide.
WIDE = CONSTANT.vary(
    load={
        "initial_loading": [(LOOP_LOAD, 0.0)],
        "cycle": [(LOOP_LOAD, 0.475 * LOOP_LOAD), (LOOP_LOAD, -0.475 * LOOP_LOAD)],
    }
)


PLACES = np.linspace(0, 1, 14401)  # straight between: chords of 1,441 show in f


@cache
def loop_of_theory(scene, friction):
    """U and Q at `PLACES` of the second cycle."""
    path = scene.load.path()
    times = path.cycle_start + path.period * (1 + PLACES)
    solution = semi_analytic.solve(
        scene.vary(friction=friction), x=0.0, time=times, fields="tangential_displacement"
    )
    return solution.tangential_displacement, path.at(times)[1]


def rows_of(scene, friction, count=4000, cycles=20.0, noise=0.0, seed=0):
    """U and Q as a rig with 0.3 times the compliance of the contact would write them; noise is a
    share of the amplitudes.
    """
    random = np.random.default_rng(seed)
    shift, force = loop_of_theory(scene, friction)
    rig = 0.3 * np.ptp(shift) / np.ptp(force)
    share = np.mod(0.2 + np.linspace(0, cycles, count), 1.0)
    u, q = (np.interp(share, PLACES, values) for values in (shift + rig * force + 0.01, force))
    u, q = (
        values + noise * np.ptp(values) / 2 * random.standard_normal(count) for values in (u, q)
    )
    return u, q, rig


def loop_of(u, q):
    return MeasuredLoop("loop.csv", u, q, np.arange(len(u), dtype=float))


def test_friction_to_one_per_cent_at_two_per_cent_noise_within_its_interval():
    """20,000 rows of 100 cycles: what a rig writes in minutes."""
    errors = []
    inside = 0
    for seed in range(4):
        u, q, _ = rows_of(WIDE, 0.5, 20_000, 100.0, 0.02, seed=seed)
        loop_score = score_loop(loop_of(u, q), WIDE)
        errors.append(loop_score.friction / 0.5 - 1)
        inside += loop_score.lowest_friction <= 0.5 <= loop_score.highest_friction
        assert loop_score.noise == pytest.approx(0.02 * np.ptp(u) / 2, rel=0.2)
        assert (
            abs(loop_score.loops[0].area - loop_score.loops[1].area)
            < 2 * loop_score.loops[0].area_uncertainty
        )
        assert (loop_score.highest_friction - loop_score.lowest_friction) / 2 < 0.01 * 0.5
    assert np.max(np.abs(errors)) < 0.01
    assert inside >= 3


def test_a_given_rig_and_the_files_own_size_of_the_load():
    u, q, rig = rows_of(WIDE, 0.5)
    loop_score = score_loop(loop_of(u, q), WIDE, rig_compliance=rig)
    assert (loop_score.compliance, loop_score.is_compliance_fitted) == (rig, False)
    assert loop_score.friction == pytest.approx(0.5, rel=1e-4)
    wrong = score_loop(loop_of(u, q), WIDE, rig_compliance=2 * rig)
    assert wrong.loops[1].distance > 100 * loop_score.loops[1].distance
    # U and Q twice as large with twice the f are the same loop, twice as large.
    twice = score_loop(loop_of(2 * u, 2 * q), WIDE)
    assert (twice.scale, twice.friction) == (
        pytest.approx(2.0, rel=1e-6),
        pytest.approx(1.0, rel=1e-4),
    )
    assert any("2 times that of the scene" in sentence for sentence in twice.notes)
    assert twice.loops[1].area == pytest.approx(4 * loop_score.loops[1].area, rel=1e-3)


@pytest.mark.parametrize("stated_rig", [False, True])
def test_degrees_of_freedom_are_rows_minus_fitted_parameters(monkeypatch, stated_rig):
    """A parameter that is fitted moves with the residuals, and no other does. Range and slide are
    not both fitted.
    """
    fits = []
    interval_of = loop_steady_rows.fit_with_interval
    monkeypatch.setattr(
        "reports.scoring.loop_steady_rows.fit_with_interval",
        lambda *given: fits.append(interval_of(*given)) or fits[-1],
    )
    u, q, rig = rows_of(WIDE, 0.5, count=60, cycles=3.0, noise=0.01)
    score_loop(loop_of(u, q), WIDE, rig_compliance=rig if stated_rig else None)
    [fit] = fits
    n_fitted = int(np.sum(fit.influence.any(axis=1)))
    assert n_fitted == (5 if stated_rig else 6)
    assert fit.degrees_of_freedom == len(fit.distances.signed_distance) - n_fitted


def test_at_constant_normal_load_the_form_of_q_over_time_does_not_matter():
    sine = WIDE.vary(
        load={
            "kind": "ellipse",
            "mean_normal_load": LOOP_LOAD,
            "tangential_amplitude": 0.475 * LOOP_LOAD,
            "phase_degrees": 90.0,
        }
    )
    u, q, _ = rows_of(sine, 0.5)
    loop_score = score_loop(loop_of(u, q), WIDE)
    assert loop_score.friction == pytest.approx(0.5, rel=1e-3)
    assert any(
        "the form of Q and U over time counts for nothing" in sentence
        for sentence in loop_score.notes
    )


def test_rows_at_uneven_steps_need_no_times():
    u, q, _ = rows_of(PAPER, 0.9, count=400, cycles=2.0)
    chosen = np.sort(np.random.default_rng(2).choice(len(u), 150, replace=False))
    loop_score = score_loop(loop_of(u[chosen], q[chosen]), PAPER)
    assert loop_score.friction == pytest.approx(0.9, rel=1e-4)
    assert loop_score.lowest_friction < 0.9 < loop_score.highest_friction


def test_a_loop_that_hardly_opens_has_no_upper_limit():
    u, q, _ = rows_of(CONSTANT, 5.0, 400, 4.0, 0.02)
    loop_score = score_loop(loop_of(u, q), CONSTANT)
    assert loop_score.highest_friction is None
    assert "no upper limit" in loop_score.sentence
    assert loop_score.lowest_friction < 5.0


@pytest.mark.slow
def test_finite_elements_lie_beside_theory():
    u, q, _ = rows_of(CONSTANT, 0.5)
    loop_score = score_loop(loop_of(u, q), CONSTANT, against="fe")
    rows = {row.name: row for row in loop_score.loops}
    assert rows["finite elements, best f"].area == pytest.approx(
        rows["theory, best f"].area, rel=3e-3
    )
    assert rows["finite elements, best f"].slope == pytest.approx(
        rows["theory, best f"].slope, rel=1e-3
    )


def loop_written(path: Path, u, q, head="U,Q", **options):
    np.savetxt(
        path,
        np.column_stack([u, q]),
        delimiter=",",
        header=head,
        comments="",
        fmt="%.9g",
        **options,
    )


def test_the_command_writes_a_page_and_its_json(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    u, q, _ = rows_of(WIDE, 0.5, 2000, 10.0, 0.02)
    loop_written(tmp_path / "loop.csv", u, q, "U [mm],Q [N/mm]")
    WIDE.save("rig.toml")
    words = ["score", "loop.csv", "--as", "loop", "--scene", "rig.toml", "--quiet"]
    assert main(words) == 0
    out = capsys.readouterr().out
    assert "lies within this interval" in out
    page = Path("out/score-loop/report.html").read_text(encoding="utf-8")
    assert "The loop is best fitted by f = 0.5" in page or "f = 0.49" in page
    assert "halfplane score loop.csv" in page
    assert "--as loop" in page
    stored = json.loads(Path("out/score-loop/loop.json").read_text(encoding="utf-8"))
    assert main([*words, "--json", "--rig-compliance", "1e-5"]) in (0, 1)
    answer = json.loads(capsys.readouterr().out)["result"]
    assert answer["rig_compliance"] == {"value": 1e-5, "fitted": False}
    assert "With the stated rig compliance the best fit is" in str(answer)
    assert {"metrics", "friction", "sentence", "page", "scene"} <= answer.keys()
    assert stored["friction"]["low"] < stored["friction"]["value"] < stored["friction"]["high"]
    assert Path("out/score-loop/figures/loop.csv").is_file()
    # Another f than the file's is outside its interval.
    WIDE.vary(friction=0.6).save("other.toml")
    assert main(["score", "loop.csv", "--as", "loop", "--scene", "other.toml", "--quiet"]) == 1


LOOP_FAULTS = {
    "no U": ("a,Q", lambda u, q: (u, q), (), "no column for the relative displacement"),
    "no Q": ("U,b", lambda u, q: (u, q), (), "no column for tangential_load"),
    "two Q": ("Q,Ft [N/mm]", lambda u, q: (u, q), (), "no column for the relative displacement"),
    "unit": (
        "U [V],Q",
        lambda u, q: (u, q),
        (),
        "the column 'U [V]' is in V, and the scene in mm: state factors.length",
    ),
    "force": (
        "U,Q [kN]",
        lambda u, q: (u, q),
        (),
        "the column 'Q [kN]' is in kN, and the scene in N/mm: state factors.load",
    ),
    "too few": ("U,Q", lambda u, q: (u[:19], q[:19]), (), "19 rows are too few for a loop"),
    "no cycle": ("U,Q", lambda u, q: (u[:110], q[:110]), (), "its "),
    "flat": ("U,Q", lambda u, q: (0 * u, q), (), "U is the same in every row"),
    "noise": (
        "U,Q",
        lambda u, q: (u, np.random.default_rng(0).standard_normal(len(q))),
        (),
        "of its amplitude only",
    ),
    "NaN": (
        "U,Q",
        lambda u, q: (np.where(np.arange(len(u)) == 7, np.nan, u), q),
        (),
        "loop.csv, line 9: U = ",
    ),
    "time": ("time,U,Q", lambda u, q: (np.r_[0.0, 2.0, 1.0 + np.arange(2, len(u))], u, q), (), ""),
    "rig": (
        "U,Q",
        lambda u, q: (u, q),
        ("--rig-compliance", "nan"),
        "--rig-compliance nan is refused",
    ),
    "tolerance": ("U,Q", lambda u, q: (u, q), ("--tolerance", "5%"), "a loop has none"),
    "no loop": (
        "U,Q",
        lambda u, q: (u, q),
        ("--scene", str(FOLDER / "flight.toml")),
        "its loads do not repeat",
    ),
}


@pytest.mark.parametrize("name", LOOP_FAULTS)
def test_a_fault_of_a_loop_is_one_sentence(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    head, change, words, sentence = LOOP_FAULTS[name]
    u, q, _ = rows_of(CONSTANT, 0.5, 400, 2.0)
    columns = np.column_stack(change(u, q))
    if name == "time":
        columns[1, 0] = 3.5
        sentence = "line 4: time = 3 does not ascend"
    np.savetxt("loop.csv", columns, delimiter=",", header=head, comments="", fmt="%.9g")
    scene = () if "--scene" in words else ("--scene", "cattaneo-mindlin")
    assert main(["score", "loop.csv", "--as", "loop", "--quiet", *scene, *words]) == 2
    streams = capsys.readouterr()
    assert sentence in streams.err
    assert len(streams.err.splitlines()) == 1
    assert not Path("out").exists()


SPOILS = {
    "swap": lambda u, q, chance: (q, u),
    "quantise": lambda u, q, chance: (np.round(u, int(chance.integers(1, 6))), q),
    "cut": lambda u, q, chance: (u[: (left := chance.integers(1, 200))], q[:left]),
    "shuffle": lambda u, q, chance: (u, chance.permutation(q)),
    "scale": lambda u, q, chance: (
        u * 10.0 ** chance.integers(-8, 9),
        q * 10.0 ** chance.integers(-8, 9),
    ),
    "sign": lambda u, q, chance: (-u, q),
    "spike": lambda u, q, chance: (u, np.where(np.arange(200) == chance.integers(0, 200), 1e9, q)),
}


@settings(max_examples=14, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(list(SPOILS)))
def test_a_spoilt_file_is_a_score_or_one_sentence(seed, fault):
    u, q, _ = rows_of(CONSTANT, 0.5, 200, 2.0)
    try:
        loop_score = score_loop(
            loop_of(*SPOILS[fault](u, q, np.random.default_rng(seed))), CONSTANT
        )
        refusal = ""
    except InputError as refused:
        loop_score = None
        refusal = str(refused)
    assert (
        refusal.startswith("loop.csv: ")
        if loop_score is None
        else loop_score.lowest_friction <= loop_score.friction
    )
    assert (
        loop_score is None
        or loop_score.highest_friction is None
        or loop_score.friction <= loop_score.highest_friction
    )
    assert loop_score is None or np.isfinite([row.area for row in loop_score.loops]).all()
