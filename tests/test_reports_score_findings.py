"""What `score` says beside its verdict: what could not be scored, spikes in the table, causes with
a trace of their own.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import semi_analytic
from reports.cli.application import requested_tolerances
from reports.cli.results import _folder_of
from reports.cli.solving import exit_code
from reports.comparison import compare
from reports.comparison.cycles import events
from reports.comparison.words import verdict_in_few_words, verdict_in_sentences
from reports.scoring.against import report_with_diagnoses, score, score_file
from reports.scoring.causes_in_words import coupling_sentence
from reports.scoring.discrepancy import discrepancy_of
from reports.scoring.mapping import Mapping
from scenes import ContactSolution, InputError, Materials, Scene, load_scene
from scenes.solution import last_whole_cycle

STEPS = 20
CATTANEO = load_scene("cattaneo-mindlin")


def cycle_from(start: float, scene: Scene = CATTANEO, steps: int = STEPS) -> ContactSolution:
    """A steady cycle of theory that starts at this share of a period after the start of the
    path's.
    """
    path = scene.load.path()
    time = path.cycle_start + path.period * (2 + start + np.linspace(0, 1, steps + 1))
    return semi_analytic.solve(scene, x=np.linspace(-1.1, 1.1, 61), time=time)


def frames(solution: ContactSolution, form: str, *names: str) -> pd.DataFrame:
    """Rows of frames without their times, each number printed in the form."""
    points = len(solution.x)
    known = {
        "P": np.repeat(solution.normal_load, points),
        "Q": np.repeat(solution.tangential_load, points),
        "CSLIP1": solution.slip.ravel(),
    }
    columns = {
        "frame": np.repeat(np.arange(len(solution.time)), points),
        "X": np.tile(solution.x, len(solution.time)),
        "CPRESS": solution.pressure.ravel(),
        "CSHEAR1": solution.shear.ravel(),
    } | {name: known[name] for name in names}
    table = pd.DataFrame(columns)
    for name in columns.keys() - {"frame"}:
        table[name] = [form % value for value in columns[name]]
    return table


def written(table: pd.DataFrame, path: Path) -> Path:
    table.to_csv(path, index=False)
    return path


# ------------------------------------------------------------------------- a cycle from any instant
@pytest.mark.parametrize(
    ("start", "form"), [(0.0, "%.6g"), (1 / 3, "%.9g"), (0.42, "%.5g"), (0.42, "%.6g")]
)
def test_a_whole_cycle_has_its_dissipation_wherever_it_starts_and_however_it_is_printed(
    tmp_path: Path, start: float, form: str
) -> None:
    solution = cycle_from(start)
    for names in (("CSLIP1",), ("CSLIP1", "P", "Q")):
        report = score_file(
            written(frames(solution, form, *names), tmp_path / "cycle.csv"), Mapping(), CATTANEO
        )
        assert report.metric("dissipation").value == pytest.approx(0.0, abs=1e-3), names
        for key in ("permanent_stick", "largest_slip", "dissipation_density"):
            assert report.metric(key).value == pytest.approx(0.0, abs=1e-3), (key, names)
        assert report.passed


def test_a_cycle_that_starts_at_the_top_of_a_sine_is_whole(tmp_path: Path) -> None:
    """There the loads stand still, and a small error of a load is a large one of the time."""
    scene = load_scene("hertz-paper")
    top = float(scene.load.phase_degrees) / 360
    report = score_file(
        written(frames(cycle_from(top, scene, 24), "%.5g", "CSLIP1"), tmp_path / "top.csv"),
        Mapping(),
        scene,
    )
    assert report.metric("dissipation").value is not None


def test_finite_elements_on_their_own_instants_are_a_reference_for_a_cycle_from_elsewhere() -> None:
    """The reference is put on the result's instants by the phase of the path, not by the time since
    the first of them.
    """
    reference = cycle_from(0.0, steps=600)
    cycle = cycle_from(0.4)
    comparison = compare(reference, cycle)
    assert comparison.metric("shear").value < 0.02
    np.testing.assert_allclose(
        comparison.reference_cycle.tangential_load,
        comparison.result_cycle.tangential_load,
        atol=1e-9 * 90,
    )


def test_the_last_whole_cycle_of_instants() -> None:
    """The path's own where it is there, else the last period, else a part that is called one."""
    period = 1.0
    start = 1.0
    instants = np.linspace(1.0, 3.0, 21)
    indices, is_whole = last_whole_cycle(instants, period, start)
    assert (indices.tolist(), is_whole) == ([*range(10, 21)], True)
    indices, is_whole = last_whole_cycle(instants[:15], period, start)  # from 1 to 2.4
    assert (indices.tolist(), is_whole) == ([*range(11)], True)
    indices, is_whole = last_whole_cycle(instants[3:15], period, start)  # from 1.3 to 2.4
    assert (indices.tolist(), is_whole) == ([*range(1, 12)], True)
    indices, is_whole = last_whole_cycle(instants[3:12], period, start)  # from 1.3 to 2.1
    assert not is_whole
    off = instants[3:14].copy()
    off[-1] += 0.001  # a hundredth of a step
    assert last_whole_cycle(off, period, start)[1]
    off[-1] += 0.009
    assert not last_whole_cycle(off, period, start)[1]


# ------------------------------------------------------------------------- what could not be scored
def test_what_has_a_tolerance_and_no_value_is_said_beside_the_verdict_and_ends_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = frames(cycle_from(0.0), "%.6g", "CSLIP1", "P", "Q")
    part = written(table[table["frame"] < STEPS - 2], tmp_path / "part.csv")
    report = score_file(part, Mapping(), CATTANEO)
    assert (report.comparison.verdict, report.passed) == ("within", False)
    assert [metric.key for metric in report.comparison.unscored] == ["dissipation"]
    assert exit_code(report.comparison) == 1
    assert (
        "not scored, though a tolerance judges it: dissipation: exit code 1"
        in capsys.readouterr().err
    )
    assert (
        verdict_in_few_words(report.comparison) == "Partly scored: within tolerance where it was."
    )
    assert "Not scored, though a tolerance judges it: dissipation." in verdict_in_sentences(
        report.comparison
    )
    left_out = score_file(
        part, Mapping(), CATTANEO, tolerances=requested_tolerances(["dissipation=none"])
    )
    assert (exit_code(left_out.comparison), verdict_in_few_words(left_out.comparison)) == (
        0,
        "Within tolerance.",
    )
    assert "dissipation" in verdict_in_sentences(left_out.comparison)


def test_a_pressure_alone_is_scored_where_the_scene_has_no_tangential_load(tmp_path: Path) -> None:
    scene = load_scene("hertz-normal")
    x = np.linspace(-1.1, 1.1, 61)
    pressure = semi_analytic.solve(scene, x=x, time=[1.0]).pressure[0]
    table = written(pd.DataFrame({"x": x, "CPRESS": pressure}), tmp_path / "pressure.csv")
    report = score_file(table, Mapping(), scene)
    assert report.passed
    assert abs(report.metric("peak_pressure").value) < 1e-9
    assert report.comparison.result_cycle.time.tolist() == pytest.approx([1.0])
    with pytest.raises(
        InputError, match="without a shear the pressure alone does not say which instant is which"
    ):
        score_file(table, Mapping(), CATTANEO)


@pytest.mark.parametrize(
    "text",
    ['{"x": [0, 1], "p": [1, 2]}', '[{"x": 1, "p": 2}]', "[\n [1, 2]]", "<html><p>x</p></html>"],
)
def test_what_is_no_table_is_one_short_sentence(tmp_path: Path, text: str) -> None:
    path = tmp_path / "result.csv"
    path.write_text(text * 200, encoding="utf-8")
    with pytest.raises(InputError) as fault:
        score_file(path, Mapping(), CATTANEO)
    assert "this is JSON, XML or HTML and no table" in str(fault.value)
    assert len(str(fault.value)) < 300


def test_two_results_of_one_stem_do_not_share_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = _folder_of(Path("x.csv"), False)
    assert folder == Path("out/score-x")
    folder.mkdir(parents=True)
    (folder / "comparison.json").write_text(
        json.dumps({"command": "halfplane score x.csv --scene hertz-paper --out out/score-x"})
    )
    assert _folder_of(Path("x.csv"), False) == folder
    for rival, loop in ((Path("x.rpt"), False), (Path("b/x.csv"), False), (Path("x.csv"), True)):
        with pytest.raises(
            InputError,
            match=r"it holds the score of x\.csv, which this one would replace; name a folder",
        ):
            _folder_of(rival, loop)


# ---------------------------------------------------------------------- single cells that stand out
def test_a_cell_that_stands_out_is_named_with_its_line_and_column_and_hides_nothing_else(
    tmp_path: Path,
) -> None:
    solution = cycle_from(0.0)
    table = frames(solution, "%.6g", "P", "Q")
    row = 7 * len(solution.x) + 25
    table.loc[row, "CPRESS"] = "1e5"
    report = score_file(written(table, tmp_path / "spiked.csv"), Mapping(), CATTANEO)
    assert report.guesses[0].startswith(
        f"line {row + 2}, column 'CPRESS' (instant 8, x = {solution.x[25]:.6g}): pressure 100000"
    )
    # no unit is guessed from it
    assert not any("multiplied by" in sentence for sentence in report.guesses)
    assert report.comparison.verdict == "outside"  # it is scored as it is
    (diagnosis,) = report_with_diagnoses(report).diagnoses
    assert diagnosis.fault == "outlier"
    assert "obey the laws" not in verdict_in_sentences(report.comparison)


def test_a_cell_that_stands_out_does_not_hide_the_unit_of_the_others(tmp_path: Path) -> None:
    """Pressures in Pa beside a scene in MPa: the largest pressure, which the unit is found from, is
    not the spike.
    """
    table = frames(cycle_from(0.0), "%.6g", "P", "Q")
    for column in ("CPRESS", "CSHEAR1"):
        table[column] = [f"{1e6 * float(value):.6g}" for value in table[column]]
    table.loc[7 * 61 + 25, "CPRESS"] = "1e12"
    report = score_file(written(table, tmp_path / "spiked.csv"), Mapping(), CATTANEO)
    assert any("multiplied by 1e-06" in sentence for sentence in report.guesses)


def test_instants_that_share_one_time_end_the_choice_of_events(tmp_path: Path) -> None:
    """It went on for ever: where all instants are equally near, one that was chosen came out
    again.
    """
    report = score_file(
        written(frames(cycle_from(0.0), "%.6g", "P", "Q"), tmp_path / "cycle.csv"),
        Mapping(),
        CATTANEO,
    )
    cycle = report.comparison.result_cycle
    at_rest = replace(
        cycle, is_whole=False, time=np.ones_like(cycle.time), fraction=np.ones_like(cycle.time)
    )
    assert 1 <= len(events(at_rest, 0.5)) <= 6


# ----------------------------------------------------------------- causes with a trace of their own
ROLLER = Scene.model_validate(
    {
        "material": {"young_modulus": 205e3, "poisson_ratio": 0.3},
        "profile": {"kind": "hertz", "radius": 30.0},
        "friction": 0.0,
        "load": {"kind": "polygon", "initial_loading": [(12.0, 0.0)]},
    }
)


def averaged(
    half_width: float, peak: float, size: float, count: int = 5
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of elements of one size, and nodal forces of Hertz' pressure over it: their sum is
    P.
    """
    nodes = size * np.arange(-count, count + 1)
    fine = np.linspace(-half_width, half_width, 20001)
    pressure = peak * np.sqrt(np.maximum(1 - (fine / half_width) ** 2, 0.0))
    shape = np.maximum(1 - np.abs(fine - nodes[:, None]) / size, 0.0)
    return nodes, np.trapezoid(shape * pressure, fine, axis=1) / size


@pytest.mark.parametrize("elements", [0.5, 2.0])
def test_a_mesh_too_coarse_for_the_contact_is_the_mesh_and_no_load_unit_or_modulus(
    elements: float,
) -> None:
    theory = semi_analytic.solve(ROLLER, x=[0.0], time=[1.0])
    half_width = float(theory.contact_half_width[0])
    peak = float(theory.pressure[0, 0])
    x, pressure = averaged(half_width, peak, half_width / elements)
    report = score(x, pressure, None, scene=ROLLER, time=[1.0])
    assert [diagnosis.fault for diagnosis in report.diagnoses] == ["coarse_edge"]
    assert "The pressures add up to the load" in report.diagnoses[0].sentence
    # A wrong load on the same mesh is no matter of the mesh.
    wrong = score(x, 1.15 * pressure, None, scene=ROLLER, time=[1.0])
    assert not any("add up to the load" in diagnosis.sentence for diagnosis in wrong.diagnoses)


def test_a_result_on_the_coulomb_limit_where_the_reference_sticks_is_a_fault_of_the_result() -> (
    None
):
    solution = semi_analytic.solve(CATTANEO, x=np.linspace(-1.1, 1.1, 121), time=[1.5])
    report = score(
        solution.x, solution.pressure, 0.5 * solution.pressure, scene=CATTANEO, time=[1.5]
    )
    assert report.diagnoses[0].fault == "full_slip"
    assert "fault of the result" in report.diagnoses[0].sentence


def test_against_a_reference_that_has_the_coupling_its_lack_is_no_idealisation() -> None:
    unlike = {
        "upper": {"young_modulus": 2500.0, "poisson_ratio": 0.35},
        "lower": {"young_modulus": 200e3, "poisson_ratio": 0.3},
    }
    scene = CATTANEO.vary(material=Materials.model_validate(unlike))
    exact = semi_analytic.solve(scene, x=np.linspace(-12, 12, 121), time=np.linspace(4, 7, 13))
    comparison = compare(exact, exact)
    difference = discrepancy_of(comparison)
    assert difference is not None
    assert "no fault of the result" in coupling_sentence(difference)
    against = replace(
        difference, comparison=replace(comparison, reference=replace(exact, engine="halfplane_fe"))
    )
    assert "It is a fault of the result" in coupling_sentence(against)
    assert "--against fe" not in coupling_sentence(against)


@pytest.mark.parametrize(("stiffness", "named"), [(3.0, True), (30.0, True), (1e5, False)])
def test_creep_in_proportion_to_the_shear_is_a_soft_penalty_whatever_the_mesh_adds(
    stiffness: float, named: bool
) -> None:
    """The pressure is as wrong as that of a mesh, which hid the penalty."""
    solution = cycle_from(0.0, steps=30)
    half_width = 1.0
    modulus = 210e3 / (2 * (1 - 0.3**2))
    creep = np.where(
        solution.pressure > 0, solution.shear / (stiffness * modulus / half_width), 0.0
    )
    coarse = solution.pressure * (1 + 0.02 * np.cos(60 * solution.x))
    report = score(
        solution.x,
        coarse,
        solution.shear,
        scene=CATTANEO,
        time=solution.time,
        slip=solution.slip + creep,
    )
    faults = [diagnosis.fault for diagnosis in report.diagnoses]
    assert (faults[:1] == ["elastic_slip"]) == named
    if named:
        assert any(
            f"stiffness of {stiffness:.2g} E*/a_ref" in words
            for words in report.diagnoses[0].evidence
        )


def test_a_soft_penalty_shows_behind_a_shear_of_the_wrong_sign() -> None:
    solution = cycle_from(0.0, steps=30)
    creep = np.where(solution.pressure > 0, solution.shear / (10 * 115e3), 0.0)
    report = score(
        solution.x,
        solution.pressure,
        -solution.shear,
        scene=CATTANEO,
        time=solution.time,
        slip=solution.slip + creep,
    )
    assert [diagnosis.fault for diagnosis in report.diagnoses] == ["shear_sign", "elastic_slip"]


@pytest.mark.parametrize("factor", [1.005, 1.02])
def test_a_factor_of_the_shear_is_told_from_another_friction(factor: float) -> None:
    """Of 0.5 % the shear is within its tolerance and exceeds f p; another f leaves the sum of the
    shear as it is.
    """
    x = np.linspace(-1.1, 1.1, 81)
    true = semi_analytic.solve(CATTANEO, x=x, time=[4.5])
    factored = score(x, true.pressure, factor * true.shear, scene=CATTANEO, time=[4.5])
    assert [diagnosis.fault for diagnosis in factored.diagnoses] == ["shear_factor"]
    assert f"a factor of the shear alone ({factor} times)" in factored.first_sentence
    friction = 1.05 * CATTANEO.friction.coefficient
    rougher = semi_analytic.solve(CATTANEO.vary(friction=friction), x=x, time=[4.5])
    other = score(x, rougher.pressure, rougher.shear, scene=CATTANEO, time=[4.5])
    assert [diagnosis.fault for diagnosis in other.diagnoses] == ["friction"]
    assert not score(x, true.pressure, true.shear, scene=CATTANEO, time=[4.5]).diagnoses


def test_a_scale_of_x_is_found_behind_an_offset() -> None:
    """The points end within theory's contact, whose sum over them is no measure of P."""
    solution = semi_analytic.solve(CATTANEO, x=np.linspace(-1.1, 1.1, 41), time=[4.5])
    report = score(
        0.8 * solution.x + 0.35, solution.pressure, solution.shear, scene=CATTANEO, time=[4.5]
    )
    faults = {diagnosis.fault for diagnosis in report.diagnoses}
    assert faults == {"offset", "x_scale"}
    for diagnosis in report.diagnoses:
        assert not [words for words in diagnosis.evidence if "just this fault" in words]
        assert any(words.startswith("both causes together leave") for words in diagnosis.evidence)
    outside, _, last = report.first_sentence.partition("; cause: ")
    assert "is outside tolerance against half-plane theory in" in outside
    assert "the scale of x (0.8 times)" in last
    assert "the origin of x (0.35 a_ref off)" in last
