"""Findings: `halfplane diff` of two runs; reports/published/: its numbers are what the code gives,
its pages what they say.
"""

from __future__ import annotations

import json
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import case_table
import publishing
import pytest
from publishing import (
    error_of,
    frozen,
    half_plane_findings,
    index,
    key_of,
    page,
    published_by_others,
    references,
)

from command_line import halfplane, json_of, sentence
from refusals import refused_for, require_facts
from reports import Report, compare
from reports.cli.solving import write_solution
from reports.comparison import findings as baseline
from reports.comparison.findings import (
    DIFFERS,
    ONLY_A,
    ONLY_B,
    SAME,
    Difference,
    ValuesOfRun,
    difference_of_runs,
    patterned_tolerances,
)
from reports.page.content import as_json
from reports.page.writing import published
from scenes import load_scene, scene_names
from test_reports_synthetic import cattaneo_mindlin


# ----------------------------------------------------------------------------------- halfplane diff
@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folders `a` (a comparison), `alone` (one engine), `failed` (its first steps only);
    solution.nc.
    """
    root = tmp_path_factory.mktemp("runs")
    exact = cattaneo_mindlin()
    rough = cattaneo_mindlin(dissipation=1.25e-3)
    content = compare(replace(exact, engine="semi_analytic"), replace(rough, engine="halfplane_fe"))
    (root / "a").mkdir()
    (root / "a" / "comparison.json").write_text(as_json(Report(content)))
    write_solution(exact, root / "alone")
    write_solution(
        replace(exact, record=replace(exact.record, converged=False)),
        root / "failed",
        name="partial",
    )
    exact.save(root / "solution.nc")
    return root


@pytest.fixture
def a(runs: Path) -> ValuesOfRun:
    return baseline.read_run_values(runs / "a")


def with_figures(findings: ValuesOfRun, **values: float | None) -> ValuesOfRun:
    """With other values; __ stands for the point of a key, a value of `...` takes the key away."""
    named = {key.replace("__", "."): value for key, value in values.items()}
    assert named.keys() <= findings.values_by_key.keys()
    figures = {
        key: value for key, value in {**findings.values_by_key, **named}.items() if value is not ...
    }
    return replace(findings, source="b", values_by_key=figures)


def verdicts(table: Difference) -> dict[str, str]:
    """Of the rows that are not the same."""
    return {row.key: row.verdict for row in table.rows if row.verdict != SAME}


def test_a_run_holds_the_metrics_and_the_values_of_both_engines(runs: Path, a: ValuesOfRun) -> None:
    exact = cattaneo_mindlin()
    assert a.values_by_key["semi_analytic.dissipation"] == exact.dissipation
    assert a.values_by_key["halfplane_fe.dissipation"] == 1.25e-3
    assert a.values_by_key["metric.dissipation"] == pytest.approx(
        1.25e-3 / exact.dissipation - 1, rel=1e-14
    )
    assert a.values_by_key["halfplane_fe.largest_half_width"] == 1.0
    assert a.values_by_key["halfplane_fe.largest_pressure"] == exact.pressure.max()
    of_file = baseline.read_run_values(runs / "solution.nc")
    of_folder = baseline.read_run_values(runs / "alone")
    assert of_file.values_by_key == of_folder.values_by_key
    assert of_file.scene == of_folder.scene
    assert len(of_file.values_by_key) >= 5


def scaled(key: str, factor: float) -> Callable[[ValuesOfRun], tuple[ValuesOfRun, ValuesOfRun]]:
    return lambda a: (a, with_figures(a, **{key: a.values_by_key[key.replace("__", ".")] * factor}))


W = "semi_analytic__dissipation"
STICK = "semi_analytic__permanent_stick_half_width"
# Pairs of findings, and the rows that differ.
PAIRS: dict[
    str, tuple[Callable[[ValuesOfRun], tuple[ValuesOfRun, ValuesOfRun]], dict[str, str]]
] = {
    "with itself": (lambda a: (a, a), {}),
    "theory within 1e-9": (scaled(W, 1 + 0.9e-9), {}),
    "theory beyond": (scaled(W, 1 + 1.1e-9), {"semi_analytic.dissipation": DIFFERS}),
    "finite elements within 1e-6": (scaled("halfplane_fe__dissipation", 1 + 0.9e-6), {}),
    "finite elements beyond": (
        scaled("halfplane_fe__dissipation", 1 + 1.1e-6),
        {"halfplane_fe.dissipation": DIFFERS},
    ),
    "half width within": (scaled("halfplane_fe__largest_half_width", 1 - 0.9e-6), {}),
    "half width beyond": (
        scaled("halfplane_fe__largest_half_width", 1 - 1.1e-6),
        {"halfplane_fe.largest_half_width": DIFFERS},
    ),
    "metric within, absolute": (lambda a: (a, with_figures(a, metric__pressure=0.9e-6)), {}),
    "metric beyond": (
        lambda a: (a, with_figures(a, metric__pressure=1.1e-6)),
        {"metric.pressure": DIFFERS},
    ),
    "none is no number": (
        lambda a: (a, with_figures(a, **{STICK: None})),
        {STICK.replace("__", "."): DIFFERS},
    ),
    "none in both": (lambda a: 2 * (with_figures(a, **{STICK: None}),), {}),
    # A f^2 P^2 of the scene is 0.0356: 1e-18 is round-off of it, a thousandth of a thousandth of it
    # is not.
    "round-off of no work": (
        lambda a: (with_figures(a, **{W: 1e-18}), with_figures(a, **{W: -2e-18})),
        {},
    ),
    "some work": (
        lambda a: (with_figures(a, **{W: 1e-18}), with_figures(a, **{W: 1e-15})),
        {"semi_analytic.dissipation": DIFFERS},
    ),
    "lost in B": (lambda a: (a, with_figures(a, metric__state=...)), {"metric.state": ONLY_A}),
    "lost in A": (lambda a: (with_figures(a, metric__state=...), a), {"metric.state": ONLY_B}),
    "another title": (
        lambda a: (a, replace(a, scene=a.scene.vary(title="another title", name="other"))),
        {},
    ),
}


@pytest.mark.parametrize("case", PAIRS)
def test_pairs_differ_where_they_must(case: str, a: ValuesOfRun) -> None:
    pair, rows = PAIRS[case]
    table = difference_of_runs(*pair(a))
    assert (verdicts(table), table.are_same) == (rows, not rows)


def test_a_value_that_is_no_number_is_not_one_that_is_none(runs: Path) -> None:
    content = json.loads((runs / "a" / "comparison.json").read_text())
    content["metrics"]["shear"].update(value=None)
    none = baseline.run_values_of_content(content, "none")
    content["metrics"]["shear"].update(finite=False)
    nan = baseline.run_values_of_content(content, "nan")
    assert verdicts(difference_of_runs(none, nan)) == {"metric.shear.finite": ONLY_B}
    assert difference_of_runs(nan, nan).are_same


def test_what_only_one_side_holds_at_all_is_said_and_not_compared(
    runs: Path, a: ValuesOfRun
) -> None:
    """The answer of one engine against a whole run: its own values count, and any of these that the
    run lacks.
    """
    alone = baseline.read_run_values(runs / "solution.nc")
    engine = {
        "semi_analytic" + key.removeprefix("closed_form"): value
        for key, value in alone.values_by_key.items()
    }
    table = difference_of_runs(replace(alone, values_by_key=engine), a)
    assert table.are_same
    assert {row.key.partition(".")[0] for row in table.rows} == {"semi_analytic"}
    assert table.notes == (
        "not compared, for it is only in B: halfplane_fe.*",
        "not compared, for it is only in B: metric.*",
    )
    fewer = replace(
        alone,
        values_by_key={
            key: value for key, value in engine.items() if not key.endswith("dissipation")
        },
    )
    assert verdicts(difference_of_runs(fewer, a)) == {"semi_analytic.dissipation": ONLY_B}
    engines = {**a.engines, "halfplane_fe": {"settings": {"mesh": {"order": 1}}, "versions": {}}}
    table = difference_of_runs(a, replace(a, engines=engines))
    assert (table.are_same, table.notes) == (
        True,
        ("halfplane_fe: settings.mesh.order is absent in A and 1 in B",),
    )


def test_tolerances_of_the_command_line_come_first_then_those_kept(a: ValuesOfRun) -> None:
    moved = with_figures(a, metric__shear=1e-3)
    assert not difference_of_runs(a, moved).are_same
    assert difference_of_runs(a, moved, {"metric.*": 2e-3}).are_same
    with_tolerance = replace(moved, tolerances={"metric.shear": 2e-3})
    assert difference_of_runs(a, with_tolerance).are_same
    assert not difference_of_runs(a, with_tolerance, {"metric.shear": 0.0}).are_same
    for word in (
        "metric.shear",
        "=1",
        "metric.shear=",
        "metric.shear=-1",
        "metric.shear=nan",
        "metric.shear=x",
    ):
        with refused_for(word, "KEY=VALUE"):
            patterned_tolerances([word])
    with refused_for("metric.sheer", "metric.largest_pressure", "halfplane_fe."):
        difference_of_runs(a, a, {"metric.sheer": 1.0})


def test_different_questions_and_nothing_in_common_are_refused(a: ValuesOfRun) -> None:
    with refused_for("friction.coefficient", "0.5 and 0.4"):
        difference_of_runs(a, replace(a, scene=a.scene.vary(friction=0.4)))
    with refused_for("no figure in common"):
        difference_of_runs(
            a, replace(a, values_by_key={"somebody.dissipation": 1.0}, engines={"somebody": {}})
        )


def test_same_differs_and_accept(runs: Path, tmp_path: Path) -> None:
    def diff(*words: str | Path) -> int:
        return halfplane(tmp_path, "diff", *map(str, words)).returncode

    run = runs / "a"
    changed_run = tmp_path / "b"
    stored = tmp_path / "kept" / "baseline.json"
    assert "--accept` writes it" in sentence(halfplane(tmp_path, "diff", str(run), str(stored)))
    assert [diff(run, stored, "--accept"), diff(run, stored), diff(stored, run)] == [0, 0, 0]
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["baseline.json"]
    shutil.copytree(run, changed_run)
    content = json_of(changed_run / "comparison.json")
    content["result"]["dissipation"] *= 1.001
    (changed_run / "comparison.json").write_text(json.dumps(content))
    before = stored.read_text()
    outcome = halfplane(tmp_path, "diff", "b", str(stored), "--json")
    table = json.loads(outcome.stdout)["result"]
    assert (outcome.returncode, table["same"]) == (1, False)
    assert [row["key"] for row in table["rows"] if row["verdict"] != SAME] == [
        "halfplane_fe.dissipation"
    ]
    outcome = halfplane(tmp_path, "diff", "b", str(stored))
    assert (
        f"{len(table['rows']) - 1} values are the same to the last digit and not listed"
        in outcome.stdout
    )
    outcome = halfplane(tmp_path, "diff", "b", str(stored), "--quiet")
    assert (outcome.returncode, outcome.stdout) == (1, "")
    assert diff(changed_run, stored, "--tolerance", "halfplane_fe.dissipation=2e-3") == 0
    assert stored.read_text() == before
    assert diff(changed_run, stored, "--accept", "--tolerance", "metric.*=1e-3") == 0
    assert diff(changed_run, stored) == 0
    assert baseline.read_run_values(stored).tolerances == {"metric.*": 1e-3}


def test_accept_never_writes_over_what_is_no_baseline_of_this_scene(
    runs: Path, tmp_path: Path, a: ValuesOfRun
) -> None:
    stored = tmp_path / "kept.json"
    baseline.write_baseline(replace(a, scene=load_scene("hertz-paper")), stored, {})
    for content in (stored.read_text(), '{"format": "halfplane comparison 1"}', "# notes\n", ""):
        stored.write_text(content)
        assert halfplane(tmp_path, "diff", str(runs / "a"), "kept.json", "--accept").returncode == 2
        assert stored.read_text() == content
    assert (
        halfplane(tmp_path, "diff", str(runs / "a"), str(runs / "alone"), "--accept").returncode
        == 2
    )
    with refused_for("not converged", "halfplane_fe: stuck"):
        baseline.write_baseline(replace(a, unfinished=("halfplane_fe: stuck",)), stored, {})
    assert stored.read_text() == ""


@pytest.mark.parametrize(
    ("name", "content", "facts"),
    [
        ("nothing", None, ["no such file"]),
        (".", None, ["no folder of a run"]),
        ("a.json", "{", ["JSON"]),
        ("a.json", "[]", ["neither a run nor a baseline"]),
        ("a.json", '{"format": "halfplane baseline 0"}', ["'halfplane baseline 0'"]),
        ("a.json", '{"format": "halfplane baseline 1"}', ["version 0.1", "halfplane 0.3"]),
        ("a.json", '{"format": "halfplane baseline 2"}', ["'scene'"]),
        ("a.json", '{"format": "halfplane baseline 3"}', ["later version", "update"]),
        ("a.json", '{"format": "halfplane comparison 2", "metrics": 3}', ["can't be read"]),
        ("a.nc", "not a solution", ["can't be read as a solution"]),
    ],
)
def test_what_is_neither_is_refused(
    name: str, content: str | None, facts: list[str], runs: Path, tmp_path: Path
) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    for pair in ((name, str(runs / "a")), (str(runs / "a"), name)):
        require_facts(sentence(halfplane(tmp_path, "diff", *pair)), name, *facts)
    line = sentence(halfplane(tmp_path, "diff", str(runs / "failed"), str(runs / "a")))
    require_facts(line, "before an engine failed")


def test_a_folder_with_a_damaged_solution_is_refused(tmp_path: Path) -> None:
    (tmp_path / "semi_analytic.json").write_text('{"format": "halfplane solution 2"}')
    with refused_for("can't be read as one", "'scene'"):
        baseline.read_run_values(tmp_path)


def test_an_energy_is_compared_where_a_baseline_lacks_pressure_and_half_width(
    a: ValuesOfRun,
) -> None:
    work = {"semi_analytic.dissipation": a.values_by_key["semi_analytic.dissipation"]}
    alone = replace(a, values_by_key=work)
    assert difference_of_runs(alone, replace(alone, source="b")).are_same


# -------------------------------------------------------------------------------- reports/published


STORED: dict[str, Any] = publishing.published()
RENEW = "run `make publish`, look at what moved, and say why in CHANGELOG.md"
# Half-planes without slip and with a little; make nightly has all scenes, and test_contract.py
# freezes twelve coarser ones.
CHEAP = ("full-stick",)
EVERY = pytest.mark.parametrize("name", scene_names())


def changed(then: ValuesOfRun, now: ValuesOfRun) -> list[str]:
    return [
        f"{row.key}: {row.a} -> {row.b}, {row.verdict}"
        for row in difference_of_runs(then, now).rows
        if row.verdict != SAME
    ]


def test_the_whole_library_is_published_and_nothing_else() -> None:
    assert list(STORED) == list(scene_names())
    files = {
        "README.md",
        "maps",
        *(f"{name}.{kind}" for name in scene_names() for kind in ("md", "svg")),
    }
    assert {path.name for path in publishing.FOLDER.iterdir()} == files, RENEW
    assert (publishing.FOLDER / "README.md").read_text(encoding="utf-8") == index(STORED), RENEW


@EVERY
def test_half_plane_figures_are_what_the_code_gives(name: str) -> None:
    findings = frozen(name, STORED[name])
    keys = [key for key in findings.values_by_key if key.startswith("semi_analytic.")]
    theory = {key: findings.values_by_key[key] for key in keys}
    assert changed(replace(findings, values_by_key=theory), half_plane_findings(name)) == [], RENEW


@pytest.mark.parametrize(
    "name",
    [
        name if name in CHEAP else pytest.param(name, marks=pytest.mark.slow)
        for name in scene_names()
    ],
)
def test_figures_of_both_engines_are_what_the_code_gives(name: str) -> None:
    """Pictures are drawn alike twice, without fonts and dates."""
    comparison = publishing.compute(name)
    before = publishing.cases_of(case_table.sheet(name))
    assert publishing.changes(before, publishing.baselines(comparison)) == {}, RENEW
    assert published(comparison) == published(comparison)


@EVERY
def test_pages_say_what_the_numbers_say_and_these_agree_with_closed_forms_and_published_values(
    name: str,
) -> None:
    """The external column, within its own tolerances: it is not renewed by what we compute."""
    assert (publishing.FOLDER / f"{name}.md").read_text(encoding="utf-8") == page(
        name, STORED[name]
    ), RENEW
    scene = load_scene(name)
    stored = STORED[name]
    load = stored["largest_normal_load"]
    known = references(name)
    assert {key_of(reference) for reference in known} >= {"semi_analytic.dissipation"}
    for reference in known:
        error = error_of(reference, stored["frozen"], scene, load)
        assert abs(error) <= reference.tolerance, reference
    text = (publishing.FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    assert len(text) < 60_000
    assert ET.fromstring(text).tag.endswith("svg")
    assert not [word for word in ("@font-face", "dc:date", "data:") if word in text]


@pytest.mark.parametrize("name", ["cylinder-roller", "cylinder-roller-frictionless"])
def test_the_published_roller_is_met_once_displacements_are_large(name: str) -> None:
    """Ours miss the quadratic elements' values by 2 to 3 %; with CalculiX' change to large
    displacements by less than 1 %.
    """
    cases = json.loads(publishing.ROLLER.read_text(encoding="utf-8"))
    small, large = (cases[f"{name}: {change}"] for change in ("as exported", "large displacements"))
    for quantity, key in (
        ("lower_face_displacement", "displacement"),
        ("largest_pressure", "stress"),
    ):
        (theirs,) = [
            number
            for number in published_by_others(load_scene(name))
            if number.quantity == quantity and "quadratic" in number.source
        ]
        ours = STORED[name]["frozen"][f"halfplane_fe.{quantity}"]
        assert abs(ours / theirs.value - 1) > 0.015
        assert abs(ours / theirs.value * large[key] / small[key] - 1) < 0.01
        assert theirs.source in page(name, STORED[name])
