"""What is said of two solutions: the question, values with units, the verdict, the headline; `halfplane diff` of two runs."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import halfplane, sentence
from reports import Report, compare
from reports.cli import findings as baseline
from reports.cli.findings import DIFFERS, ONLY_A, ONLY_B, SAME, Difference, Findings, difference, tolerances_of
from reports.cli.solving import write_solution
from reports.comparison.content import as_json
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

TRUTH = cattaneo_mindlin(steps_per_leg=10, points=41)


# ------------------------------------------------------------------------------------------------------------------ words
def scene(**changed: Any) -> Scene:
    return Scene.model_validate(load_scene("hertz-paper").model_dump() | changed)


LINES = {"kind": "polygon", "initial_loading": [[2.0, 0.0]]}
CYCLE = LINES | {"cycle": [[2.0, 1.0]]}
MATERIAL = {part: {"young_modulus": e, "poisson_ratio": 0.3} for part, e in (("upper", 70e3), ("lower", 210e3))}
QUESTIONS = [
    ({"profile": {"kind": "wedge", "tip_radius": 10.0, "tip_half_length": 0.25}}, "a wedge whose tip of half-length 0.25 mm"),
    ({"load": CYCLE}, "round the straight lines through (2, 0), (2, 1)"),
    ({"load": CYCLE}, "what does a cycle dissipate?"),
    ({"load": LINES}, "along the straight lines through (0, 0), (2, 0) N/mm"),
    ({"load": LINES}, "what does the path dissipate?"),
    ({"load": {"kind": "time_series", "rows": [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]]}}, "what does the path dissipate?"),
    ({"units": "lbf, in, psi"}, "E = 210000 psi"),
    ({"units": "SI"}, "force/length"),
    ({"material": MATERIAL}, "upper E = 70000 MPa, ν = 0.3; lower E = 210000 MPa, ν = 0.3"),
]


def test_question_has_the_scene_s_own_words() -> None:
    for changed, words in QUESTIONS:
        assert words in question(scene(**changed))
    for name in scene_names():
        asked = question(load_scene(name))
        assert not [words for words in ("friction coefficient", "MPa", "N/mm") if words not in asked]
        assert asked.endswith("?")
    assert units(scene(units="SI")) == ("force", "length", "stress")


def test_values_have_sign_unit_elements_and_no_more_digits_than_are_known() -> None:
    edges = TRUTH.stick_edges - np.array([0.0, 0.01])
    found = compare(TRUTH, with_fields(TRUTH, stick_edges=edges, settings={"element_size": 0.02}))
    edge, norm = found.metric("stick_edge"), found.metric("pressure")
    assert (value_of(edge), unit_of(edge), tolerance_of(edge)) == ("−1 %", "of a_ref (−0.5 elements)", "2.5 %")
    assert (value_of(norm), unit_of(norm)) == ("0 %", "of ‖p_ref‖")
    metric = compare(with_fields(TRUTH, dissipation=0.0), with_fields(TRUTH, dissipation=0.01)).metric("dissipation")
    assert "%" not in value_of(metric) + tolerance_of(metric)
    assert unit_of(metric) == "A f² P_ref²"
    for value, text in ((1.87e-16, "0 %"), (-9e-14, "0 %"), (-2e-13, "−2e−11 %"), (1e-5, "+0.001 %")):  # round-off is nothing
        assert value_of(Metric(definition=METRICS["dissipation_step"], value=value)) == text
        absolute = value_of(Metric(definition=METRICS["dissipation_step"], value=value, absolute=True))
        assert (absolute == "0") == (text == "0 %")
    known = {
        (2.8512, 0.0614): "2.85 ± 0.06",
        (0.5, 0.0113): "0.500 ± 0.011",
        (12.0, 35.2): "12 ± 35",
        (1e-9, 2e-9): "1e−09 ± 2e−09",
    }
    assert {pair: with_uncertainty(*pair) for pair in known} == known


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


def test_the_headline_says_how_wrong_theory_is_and_how_far_both_agree() -> None:
    """W of the finite elements 2 % low: theory is 1/0.98 - 1 = 2.04 % high; digits follow the uncertainty."""
    assert headline(bodies(0.98, 1.005, 6e-4)) == (
        "Half-plane theory overestimates the dissipation by 2.04 ± 0.06 % and underestimates the peak pressure by 0.50 ± 0.06 % "
        "for these bodies (theory/finite elements − 1)."
    )
    assert "gives the dissipation to within its uncertainty (0.01 ± 0.06 %)" in headline(bodies(0.9999, 1.005, 6e-4))
    assert "by 2.04 %" in headline(bodies(0.98))
    assert "no uncertainty was measured" in headline(bodies(0.98))
    theory = with_fields(TRUTH, engine="semi_analytic")
    near = with_fields(theory, engine="halfplane_fe", dissipation=1.0004 * TRUTH.dissipation)
    agree = "The two solutions agree to 0.04 % in the dissipation and 0 % in the peak pressure; no uncertainty was measured."
    assert headline(Report(compare(theory, near))) == agree
    known = with_fields(near, dissipation_uncertainty=5e-4 * near.dissipation)
    assert headline(Report(compare(theory, known))).endswith(
        "errors of the dissipation by their own estimates: finite elements 0.05 %."
    )
    other = with_fields(theory, engine="another code", dissipation=1.02 * TRUTH.dissipation)
    said = headline(Report(compare(theory, other)))
    assert said.startswith(
        "another code, measured by half-plane theory, overestimates the dissipation by 2 % and agrees in the peak pressure"
    )


def test_bodies_without_a_tolerance_are_not_judged() -> None:
    """Errors with uncertainties, no verdict, passed; a tolerance that is asked for judges them."""
    free = bodies(0.98, 1.0, 6e-4)
    assert (free.comparison.verdict, free.passed, lead(free)) == (None, True, "")
    assert "nothing is judged" in verdict(free)
    for tolerance, wanted in ((0.05, "within"), (0.01, "outside"), (0.02, "undecided")):
        asked = bodies(0.98, 1.0, 6e-4, dissipation=tolerance)
        assert (asked.comparison.verdict, asked.passed) == (wanted, wanted == "within")
    with pytest.raises(InputError, match="tolerances: 'disipation' is no metric"):
        bodies(0.98, disipation=0.01)


def test_the_first_table_has_both_values_in_the_scene_s_units() -> None:
    heads, rows = first_table(bodies(0.98, 1.005, 6e-4))
    assert heads == ("", "theory", "finite elements", "difference", "verdict")
    table = {row["key"]: row for row in rows}
    work = table["dissipation"]
    assert float(work["result"].replace("−", "-")) == pytest.approx(0.98 * TRUTH.dissipation, rel=1e-4)
    assert (work["label"], work["difference"], work["verdict"]) == ("Dissipation [N·mm/mm]", "−2.00 ± 0.06 %", "–")
    assert float(table["largest_pressure"]["reference"]) == pytest.approx(TRUTH.pressure.max(), rel=1e-4)
    assert table["permanent_stick"]["difference"].endswith(" of a")
    assert table["largest_slip"]["label"] == "Largest slip [µm]"
    text = bodies(0.98, 1.005, 6e-4).summary()
    assert text.startswith("Half-plane theory overestimates")
    assert all(row["difference"] in text for row in rows)


# ------------------------------------------------------------------------------------------------------- halfplane diff
@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folders `a` (a comparison), `alone` (one engine), `failed` (its first steps only); solution.nc."""
    root = tmp_path_factory.mktemp("runs")
    exact, rough = cattaneo_mindlin(), cattaneo_mindlin(dissipation=1.25e-3)
    content = compare(replace(exact, engine="semi_analytic"), replace(rough, engine="halfplane_fe"))
    (root / "a").mkdir()
    (root / "a" / "comparison.json").write_text(as_json(Report(content)))
    write_solution(exact, root / "alone")
    write_solution(replace(exact, record=replace(exact.record, converged=False)), root / "failed", name="partial")
    exact.save(root / "solution.nc")
    return root


@pytest.fixture
def a(runs: Path) -> Findings:
    return baseline.read_findings(runs / "a")


def with_figures(findings: Findings, **values: float | None) -> Findings:
    """With other values; __ stands for the point of a key, a value of `...` takes the key away."""
    named = {key.replace("__", "."): value for key, value in values.items()}
    assert named.keys() <= findings.figures.keys()
    figures = {key: value for key, value in {**findings.figures, **named}.items() if value is not ...}
    return replace(findings, source="b", figures=figures)


def verdicts(found: Difference) -> dict[str, str]:
    """Of the rows that are not the same."""
    return {row.key: row.verdict for row in found.rows if row.verdict != SAME}


def test_a_run_holds_the_metrics_and_the_values_of_both_engines(runs: Path, a: Findings) -> None:
    exact = cattaneo_mindlin()
    assert a.figures["semi_analytic.dissipation"] == exact.dissipation
    assert a.figures["halfplane_fe.dissipation"] == 1.25e-3
    assert a.figures["metric.dissipation"] == pytest.approx(1.25e-3 / exact.dissipation - 1, rel=1e-14)
    assert a.figures["halfplane_fe.largest_half_width"] == 1.0
    assert a.figures["halfplane_fe.largest_pressure"] == exact.pressure.max()
    stored, folder = baseline.read_findings(runs / "solution.nc"), baseline.read_findings(runs / "alone")
    assert (stored.figures, stored.scene, len(stored.figures) >= 5) == (folder.figures, folder.scene, True)


def scaled(key: str, factor: float) -> Callable[[Findings], tuple[Findings, Findings]]:
    return lambda a: (a, with_figures(a, **{key: a.figures[key.replace("__", ".")] * factor}))


def placed(one: float, other: float) -> Callable[[Findings], tuple[Findings, Findings]]:
    return lambda a: (with_figures(a, metric__pressure_peak_place=one), with_figures(a, metric__pressure_peak_place=other))


W, STICK, PLACE = "semi_analytic__dissipation", "semi_analytic__permanent_stick_half_width", "metric.pressure_peak_place"
# Pairs of findings, and the rows that differ.
PAIRS: dict[str, tuple[Callable[[Findings], tuple[Findings, Findings]], dict[str, str]]] = {
    "with itself": (lambda a: (a, a), {}),
    "theory within 1e-9": (scaled(W, 1 + 0.9e-9), {}),
    "theory beyond": (scaled(W, 1 + 1.1e-9), {"semi_analytic.dissipation": DIFFERS}),
    "finite elements within 1e-6": (scaled("halfplane_fe__dissipation", 1 + 0.9e-6), {}),
    "finite elements beyond": (scaled("halfplane_fe__dissipation", 1 + 1.1e-6), {"halfplane_fe.dissipation": DIFFERS}),
    "half width within": (scaled("halfplane_fe__largest_half_width", 1 - 0.9e-6), {}),
    "half width beyond": (scaled("halfplane_fe__largest_half_width", 1 - 1.1e-6), {"halfplane_fe.largest_half_width": DIFFERS}),
    "metric within, absolute": (lambda a: (a, with_figures(a, metric__pressure=0.9e-6)), {}),
    "metric beyond": (lambda a: (a, with_figures(a, metric__pressure=1.1e-6)), {"metric.pressure": DIFFERS}),
    "none is no number": (lambda a: (a, with_figures(a, **{STICK: None})), {STICK.replace("__", "."): DIFFERS}),
    "none in both": (lambda a: 2 * (with_figures(a, **{STICK: None}),), {}),
    "mirrored peaks": (placed(-0.1, 0.1), {}),
    "peaks apart": (placed(-0.1, 0.11), {PLACE: DIFFERS}),
    # A f^2 P^2 of the scene is 0.0356: 1e-18 is round-off of it, a thousandth of a thousandth of it is not.
    "round-off of no work": (lambda a: (with_figures(a, **{W: 1e-18}), with_figures(a, **{W: -2e-18})), {}),
    "some work": (lambda a: (with_figures(a, **{W: 1e-18}), with_figures(a, **{W: 1e-15})), {"semi_analytic.dissipation": DIFFERS}),
    "lost in B": (lambda a: (a, with_figures(a, metric__state=...)), {"metric.state": ONLY_A}),
    "lost in A": (lambda a: (with_figures(a, metric__state=...), a), {"metric.state": ONLY_B}),
    "another title": (lambda a: (a, replace(a, scene=a.scene.vary(title="another title", name="other"))), {}),
}


@pytest.mark.parametrize("case", PAIRS)
def test_pairs_differ_where_they_must(case: str, a: Findings) -> None:
    pair, rows = PAIRS[case]
    found = difference(*pair(a))
    assert (verdicts(found), found.same) == (rows, not rows)


def test_a_value_that_is_no_number_is_not_one_that_is_none(runs: Path) -> None:
    content = json.loads((runs / "a" / "comparison.json").read_text())
    content["metrics"]["shear"].update(value=None)
    none = baseline.of_content(content, "none")
    content["metrics"]["shear"].update(finite=False)
    nan = baseline.of_content(content, "nan")
    assert verdicts(difference(none, nan)) == {"metric.shear.finite": ONLY_B}
    assert difference(nan, nan).same


def test_what_only_one_side_holds_at_all_is_said_and_not_compared(runs: Path, a: Findings) -> None:
    """The answer of one engine against a whole run: its own values count, and any of these that the run lacks."""
    alone = baseline.read_findings(runs / "solution.nc")
    engine = {"semi_analytic" + key.removeprefix("closed_form"): value for key, value in alone.figures.items()}
    found = difference(replace(alone, figures=engine), a)
    assert found.same
    assert {row.key.partition(".")[0] for row in found.rows} == {"semi_analytic"}
    assert found.notes == ("not compared, for it is only in B: halfplane_fe.*", "not compared, for it is only in B: metric.*")
    fewer = replace(alone, figures={key: value for key, value in engine.items() if not key.endswith("dissipation")})
    assert verdicts(difference(fewer, a)) == {"semi_analytic.dissipation": ONLY_B}
    engines = {**a.engines, "halfplane_fe": {"settings": {"mesh": {"order": 1}}, "versions": {}}}
    found = difference(a, replace(a, engines=engines))
    assert (found.same, found.notes) == (True, ("halfplane_fe: settings.mesh.order is absent in A and 1 in B",))


def test_tolerances_of_the_command_line_come_first_then_those_kept(a: Findings) -> None:
    other = with_figures(a, metric__shear=1e-3)
    assert not difference(a, other).same
    assert difference(a, other, {"metric.*": 2e-3}).same
    kept = replace(other, tolerances={"metric.shear": 2e-3})
    assert difference(a, kept).same
    assert not difference(a, kept, {"metric.shear": 0.0}).same
    for word in ("metric.shear", "=1", "metric.shear=", "metric.shear=-1", "metric.shear=nan", "metric.shear=x"):
        with pytest.raises(InputError, match="KEY=VALUE"):
            tolerances_of([word])
    with pytest.raises(InputError, match=r"no figure is called so; there are metric\.largest_pressure, .*halfplane_fe\."):
        difference(a, a, {"metric.sheer": 1.0})


def test_different_questions_and_nothing_in_common_are_refused(a: Findings) -> None:
    with pytest.raises(InputError, match=r"different scenes: friction\.coefficient is 0\.5 and 0\.4$"):
        difference(a, replace(a, scene=a.scene.vary(friction=0.4)))
    with pytest.raises(InputError, match="no figure in common"):
        difference(a, replace(a, figures={"somebody.dissipation": 1.0}, engines={"somebody": {}}))


def test_same_differs_and_accept(runs: Path, tmp_path: Path) -> None:
    def diff(*words: str | Path) -> int:
        return halfplane(tmp_path, "diff", *map(str, words)).returncode

    run, other, kept = runs / "a", tmp_path / "b", tmp_path / "kept" / "baseline.json"
    assert "--accept` writes it" in sentence(halfplane(tmp_path, "diff", str(run), str(kept)))
    assert [diff(run, kept, "--accept"), diff(run, kept), diff(kept, run)] == [0, 0, 0]
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["baseline.json"]
    shutil.copytree(run, other)
    content = json.loads((other / "comparison.json").read_text())
    content["result"]["dissipation"] *= 1.001
    (other / "comparison.json").write_text(json.dumps(content))
    before = kept.read_text()
    done = halfplane(tmp_path, "diff", "b", str(kept), "--json")
    table = json.loads(done.stdout)["result"]
    assert (done.returncode, table["same"]) == (1, False)
    assert [row["key"] for row in table["rows"] if row["verdict"] != SAME] == ["halfplane_fe.dissipation"]
    done = halfplane(tmp_path, "diff", "b", str(kept))
    assert f"{len(table['rows']) - 1} values are the same to the last digit and not listed" in done.stdout
    done = halfplane(tmp_path, "diff", "b", str(kept), "--quiet")
    assert (done.returncode, done.stdout) == (1, "")
    assert diff(other, kept, "--tolerance", "halfplane_fe.dissipation=2e-3") == 0
    assert kept.read_text() == before
    assert [diff(other, kept, "--accept", "--tolerance", "metric.*=1e-3"), diff(other, kept)] == [0, 0]
    assert baseline.read_findings(kept).tolerances == {"metric.*": 1e-3}


def test_accept_never_writes_over_what_is_no_baseline_of_this_scene(runs: Path, tmp_path: Path, a: Findings) -> None:
    kept = tmp_path / "kept.json"
    baseline.write_baseline(replace(a, scene=load_scene("hertz-paper")), kept, {})
    for content in (kept.read_text(), '{"format": "halfplane comparison 1"}', "# notes\n", ""):
        kept.write_text(content)
        assert halfplane(tmp_path, "diff", str(runs / "a"), "kept.json", "--accept").returncode == 2
        assert kept.read_text() == content
    assert halfplane(tmp_path, "diff", str(runs / "a"), str(runs / "alone"), "--accept").returncode == 2
    with pytest.raises(InputError, match="not converged, so no baseline: halfplane_fe: stuck"):
        baseline.write_baseline(replace(a, unfinished=("halfplane_fe: stuck",)), kept, {})
    assert kept.read_text() == ""


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("nothing", None, "no such file"),
        (".", None, "no folder of a run"),
        ("a.json", "{", "can't be read as JSON"),
        ("a.json", "[]", "neither a run nor a baseline"),
        ("a.json", '{"format": "halfplane baseline 0"}', "format is 'halfplane baseline 0'"),
        ("a.json", '{"format": "halfplane baseline 1"}', "can't be read as one: 'scene'"),
        ("a.json", '{"format": "halfplane baseline 3"}', "of a later version; update halfplane"),
        ("a.json", '{"format": "halfplane comparison 1", "metrics": 3}', "can't be read as one"),
        ("a.nc", "not a solution", "can't be read as a solution"),
    ],
)
def test_what_is_neither_is_refused_in_a_sentence(name: str, content: str | None, says: str, runs: Path, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    for pair in ((name, str(runs / "a")), (str(runs / "a"), name)):
        assert says in sentence(halfplane(tmp_path, "diff", *pair))
    line = sentence(halfplane(tmp_path, "diff", str(runs / "failed"), str(runs / "a")))
    assert "only the steps before an engine failed" in line
