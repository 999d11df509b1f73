"""The published reports, reports/published/: a page and a picture for each scene of the library.

    make publish            (python benchmarks/publishing.py, some minutes)
    make publish PAGES=1    (... --pages: the pages alone, from the numbers that are there)
    python benchmarks/publishing.py NAME ...   (the named scenes; all others stay as they are)

Every number on the pages is one of the table of cases (`case_table`), in two columns, kept apart.
*External*: the references of the scene, with their tolerances; nothing that we compute goes into
it. *Frozen*: the baselines of both engines with their default settings. A baseline that is met
stays as it is; one that moved is printed as old, new and reference, and replaced.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import case_table
from case_table import Case, Sheet

from reports.charts.templating import markdown_table, template
from reports.comparison import words
from reports.comparison.findings import (
    NAMES_OF_COUNTS,
    SAME,
    ValuesOfRun,
    difference_of_runs,
    run_values_of_content,
    run_values_of_solution,
)
from reports.comparison.laws import QUANTITIES, verdict_on
from reports.comparison.measures import MetricValue
from reports.comparison.metrics import METRICS, Metric, tolerances_of
from reports.comparison.pairs import are_half_planes, engine_in_words
from reports.console import say
from reports.folder import replace_text
from reports.page.writing import code_commit
from reports.units import minus
from scenes import ContactSolution, Expected, InputError, Scene, load_scene, scene_names

if TYPE_CHECKING:
    from reports.comparison import Comparison

FOLDER = Path(__file__).parents[1] / "reports" / "published"
ROLLER = Path(__file__).with_name("roller.json")
# Run of the table of cases -> what its figures are called in findings.
_PARTS = {"comparison": "metric", "elements": "halfplane_fe", "theory": "semi_analytic"}
_RUNS = {part: run for run, part in _PARTS.items()}
# Tolerances of new baselines: theory at its own points repeats itself; steps are halved by
# round-off, and the next ones follow.
_THEORY_AGREES = 1e-10
_COUNTS_AGREE = 0.05


def compute(name: str) -> Comparison:
    """Both engines on a scene of the library with their default settings, compared."""
    import halfplane_fe
    import semi_analytic
    from reports.comparison import compare
    from reports.comparison.budget import theory_on_steps
    from reports.comparison.datum import effects_between

    scene = load_scene(name)
    answer = halfplane_fe.solve(scene)
    reference = semi_analytic.solve(scene, x=answer.x, time=answer.time)
    return compare(
        reference,
        answer,
        polygon_reference=theory_on_steps(answer),
        effects=effects_between(reference, answer),
    )


def half_plane_findings(name: str) -> ValuesOfRun:
    """The figures of the half-plane engine on its own points and instants: no mesh, so quick enough
    for every test run.
    """
    import semi_analytic

    scene = load_scene(name)
    solution = semi_analytic.solve(
        scene, fields=("loop_work", "pressure", "tangential_displacement")
    )
    theory_findings = run_values_of_solution(solution, name)
    return replace(
        theory_findings, values_by_key=_with_expected(theory_findings.values_by_key, solution)
    )


def _with_expected(
    figures: Mapping[str, float | None], solution: ContactSolution
) -> dict[str, float | None]:
    """The figures of an engine, and what the scene expects of it beside them."""
    engine = engine_in_words(solution.engine)
    known = dict(figures)
    for expected in solution.scene.expected:
        if expected.engine == engine:
            known.setdefault(
                f"{solution.engine}.{expected.quantity}",
                QUANTITIES[expected.quantity].value_of(solution),
            )
    return known


def findings(comparison: Comparison) -> ValuesOfRun:
    """The figures of a scene: the metrics, the finite elements', and the half-plane engine's on its
    own points.
    """
    from reports.page.content import as_json
    from reports.report import Report

    name = comparison.scene.name
    of_both = run_values_of_content(json.loads(as_json(Report(comparison))), name)
    alone = half_plane_findings(name)
    if of_both.unfinished:
        raise InputError(
            f"{name}: not converged, so not published: {'; '.join(of_both.unfinished)}"
        )
    chosen_findings = {
        key: value
        for key, value in of_both.values_by_key.items()
        if not key.startswith("semi_analytic.")
    }
    chosen_findings = _with_expected(chosen_findings, comparison.result)
    return ValuesOfRun(
        name,
        of_both.scene,
        chosen_findings | dict(alone.values_by_key),
        {**of_both.engines, **alone.engines},
    )


def published_by_others(scene: Scene) -> Iterator[Expected]:
    """What a benchmark of other codes expects of finite elements."""
    if "benchmark" in scene.tags:
        yield from (expected for expected in scene.expected if expected.engine == "finite elements")


def references(scene: str) -> list[Case]:
    """Everything that is known of a scene's whole cycle from elsewhere, theory first."""
    known = case_table.sheet(scene)
    return [
        case
        for run in (case_table.THEORY, case_table.ELEMENTS)
        for case in known.references(run)
        if not case.at
    ]


def key_of(case: Case) -> str:
    """The figure of findings that a case is of."""
    return f"{_PARTS[case.run]}.{case.quantity}"


def error_of(
    reference: Case, figures: Mapping[str, float | None], scene: Scene, largest_load: float
) -> float:
    """Difference of our figure from a reference, in the measure of its tolerance."""
    from reports.comparison.pairs import compliance_of_materials

    ours = figures[key_of(reference)]
    theirs = float(reference.value)
    if ours is None:
        return math.inf
    size = (
        abs(theirs)
        or compliance_of_materials(scene.material)
        * ((scene.friction.coefficient or 1.0) * largest_load) ** 2
    )
    return (ours - theirs) / size


# ---------------------------------------------------------------------------------- table of cases


def baselines(comparison: Comparison) -> dict[str, Case]:
    """Key of findings -> the baseline that the code gives now."""
    scene = comparison.scene.name
    commit = code_commit("*.py")
    largest_load = float(comparison.result.normal_load.max())
    rows = [
        {"run": "elements", "quantity": LARGEST_LOAD, "value": largest_load},
        {"run": "comparison", "quantity": ADMISSIBLE, "value": comparison.admissible},
    ]
    verdicts = {metric.key: metric for metric in comparison.metrics}
    for key, value in findings(comparison).values_by_key.items():
        part, _, quantity = key.partition(".")
        row: dict[str, Any] = {"run": _RUNS[part], "quantity": quantity, "value": value}
        if part == "metric" and quantity in verdicts:
            metric = verdicts[quantity]
            row |= {} if metric.accurate is None else {"accurate": metric.accurate}
            row |= {"absolute": True} if metric.absolute else {}
        if part == "semi_analytic":
            row["tolerance"] = _THEORY_AGREES
        if quantity.startswith("counts."):
            row["tolerance"] = _COUNTS_AGREE
        rows.append(row)
    cases = [case_table.case_of_row(scene, row | {"commit": commit}) for row in rows]
    return {key_of(case): case for case in cases}


LARGEST_LOAD = "largest_normal_load"
ADMISSIBLE = "admissible"


def is_published(case: Case) -> bool:
    """Whether a baseline of the table is one that this program makes."""
    if case.is_reference or case.at or case.run not in _PARTS:
        return False
    return case.run != case_table.THEORY or case.quantity in QUANTITIES


def content_of(cases: Mapping[str, Case]) -> dict[str, Any]:
    """What a page is made of: the published baselines of a scene."""
    by_key = dict(cases)
    largest_load = by_key.pop(f"halfplane_fe.{LARGEST_LOAD}").value
    admissible = by_key.pop(f"metric.{ADMISSIBLE}").value
    metrics = [case for case in by_key.values() if case.run == "comparison"]
    return {
        "largest_normal_load": largest_load,
        "admissible": admissible,
        "absolute": [case.quantity for case in metrics if case.more.get("absolute")],
        "accurate": {
            case.quantity: case.more["accurate"] for case in metrics if "accurate" in case.more
        },
        "frozen": {key: case.value for key, case in by_key.items()},
        "tolerances": {key: case.tolerance or case.least for key, case in by_key.items()},
    }


def cases_of(known: Sheet) -> dict[str, Case]:
    """Key of findings -> the published baseline in the table."""
    return {key_of(case): case for case in known.cases if is_published(case)}


def published() -> dict[str, dict[str, Any]]:
    """Scene of the library -> what its page is made of, as the table has it."""
    stored = {name: cases_of(case_table.sheet(name)) for name in scene_names()}
    return {
        name: content_of(cases) for name, cases in stored.items() if f"metric.{ADMISSIBLE}" in cases
    }


def frozen(name: str, stored: Mapping[str, Any]) -> ValuesOfRun:
    """The frozen figures of a scene, for a comparison with those of now."""
    source = case_table.file_of(name).name
    return ValuesOfRun(
        source, load_scene(name), stored["frozen"], {}, tolerances=stored["tolerances"]
    )


# ---------------------------------------------------------------------------------------- the pages

_ENGINES = ("semi_analytic", "halfplane_fe")


def page(name: str, stored: Mapping[str, Any]) -> str:
    """The page of a scene."""
    scene = load_scene(name)
    metrics_of_scene = metrics(scene, stored)
    cells = [
        (m.label, words.value_in_words(m), m.unit, words.tolerance_in_words(m), m.verdict or "–")
        for m in metrics_of_scene
    ]
    return _written(
        scene=scene,
        stored=stored,
        found=metrics_of_scene,
        half_planes=are_half_planes(scene),
        bodies=" ".join(
            filter(
                None,
                (
                    of(scene)
                    for of in (
                        words.bodies_in_words,
                        words.unlike_materials_in_words,
                        words.idealisation_in_words,
                    )
                ),
            )
        ),
        heads=("metric", "discrepancy", "as a share", "tolerance", "accurate"),
        judged=[
            row for row, m in zip(cells, metrics_of_scene, strict=True) if m.tolerance is not None
        ],
        others=[
            row[:3] for row, m in zip(cells, metrics_of_scene, strict=True) if m.tolerance is None
        ],
        external=_external_rows(scene, stored),
        roller=_causes(scene, stored["frozen"]),
        engines=[engine_in_words(engine) for engine in _ENGINES],
        frozen=_frozen_rows(scene, stored["frozen"]),
    )


def index(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    """The page that lists all."""
    rows = []
    for name, stored in scenes.items():
        scene = load_scene(name)
        metrics_by_key = {metric.key: metric for metric in metrics(scene, stored)}
        met = [
            metric.accurate
            for metric in metrics_by_key.values()
            if metric.tolerance is not None and metric.accurate is not None
        ]
        cells = [
            words.value_in_words(metrics_by_key[key])
            for key in ("peak_pressure", "shear", "dissipation")
        ]
        kind = "half-planes" if scene.bodies.half_planes else "real bodies"
        missed = [row for row in _external_rows(scene, stored) if row[5] == "outside"]
        rows.append(
            (
                f"[{name}]({name}.md)",
                scene.title,
                kind,
                *cells,
                f"{sum(met)} of {len(met)}",
                str(len(missed)),
            )
        )
    return _written(rows=rows)


def _written(rows: Sequence[Sequence[str]] = (), **content: Any) -> str:
    text = (
        template("publishing.md")
        .render(words=words, table=markdown_table, rows=rows, **content)
        .strip()
    )
    return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def metrics(scene: Scene, stored: Mapping[str, Any]) -> list[Metric]:
    """The metrics with their values and tolerances; a published run has no budget, so |E| alone is
    judged.
    """
    rows = []
    tolerances = tolerances_of(scene, are_half_planes(scene))
    for key, value in stored["frozen"].items():
        part, _, name = key.partition(".")
        if part == "metric" and not name.endswith(".finite"):
            number = math.nan if f"{key}.finite" in stored["frozen"] else value
            metric = METRICS[name]
            measured = MetricValue(value=number, absolute=name in stored["absolute"])
            rows.append(metric.with_value(measured, metric.tolerance_from(tolerances)))
    return rows


def _external_rows(scene: Scene, stored: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    for reference in references(scene.name):
        off = error_of(reference, stored["frozen"], scene, stored["largest_normal_load"])
        theirs = str(reference.value)
        yield (
            f"{QUANTITIES[reference.quantity].words}, {engine_in_words(_PARTS[reference.run])}",
            _number(stored["frozen"][key_of(reference)]),
            theirs if len(theirs) < 20 else f"{theirs[:20]}…",
            minus(f"{off:+.1e}"),
            f"{reference.tolerance:.3g}",
            verdict_on(off, reference.tolerance),
            reference.source,
        )


def _causes(scene: Scene, figures: Mapping[str, float | None]) -> dict[str, Any] | None:
    """Why the published values of the roller differ from ours, as benchmarks/third.py measured it
    with CalculiX.
    """
    roller = json.loads(ROLLER.read_text(encoding="utf-8"))
    cases = {
        name.partition(": ")[2]: case
        for name, case in roller.items()
        if name.partition(": ")[0] == scene.name
    }
    if not cases:
        return None
    base, large, coarse = (
        cases[name] for name in ("as exported", "large displacements", "elements of 1.5 mm")
    )

    def change(case: Mapping[str, float], key: str) -> str:
        return "" if case is base else _per_cent(case[key] / base[key] - 1)

    changes: dict[str, Any] = {"code": base["code"], "coarse": change(coarse, "stress")}
    changes["pressure"] = change(large, "pressure per undeformed length")
    changes["rows"] = [
        (
            name,
            minus(f"{case['displacement']:.4f}"),
            change(case, "displacement"),
            minus(f"{-case['stress']:.0f}"),
            change(case, "stress"),
        )
        for name, case in cases.items()
    ]
    for key, quantity in (
        ("displacement", "lower_face_displacement"),
        ("stress", "largest_pressure"),
    ):
        published = {
            expected.source: expected.value
            for expected in scene.expected
            if expected.quantity == quantity
        }
        quadratic = next(v for source, v in published.items() if "quadratic elements" in source)
        linear = next(v for source, v in published.items() if "linear elements" in source)
        mended = (figures[f"halfplane_fe.{quantity}"] or math.nan) * (
            1 + (large[key] / base[key] - 1)
        )
        changes[key] = {
            "change": change(large, key),
            "mended": mended,
            "left": _per_cent(mended / quadratic - 1),
        }
        changes["apart"] = _per_cent(linear / quadratic - 1)  # of the stress in the end
    return changes


def _per_cent(share: float) -> str:
    return minus(f"{round(share, 4) + 0.0:+.2%}".replace("%", " %"))


def _frozen_rows(scene: Scene, figures: Mapping[str, float | None]) -> Iterator[tuple[str, ...]]:
    pulled = any(value for key, value in figures.items() if key.endswith(".bulk_work"))
    for name, quantity in QUANTITIES.items():
        keys = [f"{engine}.{name}" for engine in _ENGINES]
        if any(key in figures for key in keys):
            named = (
                "closed integral of Q dU − m_q dε"
                if pulled and name == "loop_work"
                else quantity.words
            )
            yield (
                f"{named} [{words.factor_and_unit_shown(scene, quantity.kind)[1]}]",
                *(_number(figures.get(key)) for key in keys),
            )
    for count in NAMES_OF_COUNTS:
        keys = [f"{engine}.counts.{count.replace(' ', '_')}" for engine in _ENGINES]
        if any(key in figures for key in keys):
            yield count, *(f"{figures[key]:,}" if key in figures else "–" for key in keys)


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.10g}"


# -------------------------------------------------------------------------------------- the command


def _publish(names: Sequence[str]) -> int:
    """Compute, write, and say what moved; returns how many scenes did."""
    from reports.page.writing import published as picture

    moved = 0
    for name in names:
        comparison = compute(name)
        replace_text(FOLDER / f"{name}.svg", picture(comparison))
        known = case_table.sheet(name)
        renewed = renew(known, baselines(comparison))
        moved += renewed != known
        case_table.write(renewed)
    _write_pages(published())
    for path in FOLDER.iterdir():
        if path.suffix in (".md", ".svg") and path.stem not in (*scene_names(), "README"):
            path.unlink()
    return moved


def renew(known: Sheet, now: Mapping[str, Case]) -> Sheet:
    """The sheet with every published baseline that is met as it is, and the others as they are now;
    each of these is printed as old, new and reference.
    """
    before = cases_of(known)
    changed = changes(before, now)
    exact = {key_of(case): case.value for case in references(known.scene)}
    for key, why in changed.items():
        old = before[key].value if key in before else "none"
        new = now[key].value if key in now else "none"
        say(
            f"  {known.scene}: {key}: old {old!r}, new {new!r},"
            f" reference {exact.get(key, 'none')}: {why}"
        )
    say(
        f"{known.scene}: {len(changed)} baselines moved" if changed else f"{known.scene}: as it was"
    )
    cases_left = [
        case for case in known.cases if not is_published(case) or key_of(case) not in changed
    ]
    renewed = []
    for key in changed:
        if key in now and key in before:
            renewed.append(replace(now[key], tolerance=before[key].tolerance))
        elif key in now:
            renewed.append(now[key])
    return replace(known, cases=(*cases_left, *renewed))


def changes(before: Mapping[str, Case], now: Mapping[str, Case]) -> dict[str, str]:
    """Key of each published baseline that is not met -> why."""
    if f"metric.{ADMISSIBLE}" not in before:  # not published yet; `cases` may have theory's values
        return dict.fromkeys(now, "new")
    name = next(iter(now.values())).scene
    old = content_of(before)
    new = content_of(now)
    rows = difference_of_runs(frozen(name, old), frozen(name, new)).rows
    changed = {row.key: row.verdict for row in rows if row.verdict != SAME}
    for key in before.keys() & now.keys() - changed.keys():
        if before[key].more != now[key].more:
            changed[key] = "another verdict"
    for key in (f"halfplane_fe.{LARGEST_LOAD}", f"metric.{ADMISSIBLE}"):
        if not case_table.agrees(before[key], now[key].value):
            changed[key] = "differs"
    return changed


def _write_pages(scenes: Mapping[str, Mapping[str, Any]]) -> None:
    """The pages and their index, from the stored numbers: enough where only words have changed."""
    for name, stored in scenes.items():
        replace_text(FOLDER / f"{name}.md", page(name, stored))
    replace_text(FOLDER / "README.md", index(scenes))


def main(arguments: Sequence[str]) -> int:
    """Publish the whole library or the scenes named; with --pages write the pages again from the
    table of cases.
    """
    if list(arguments) == ["--pages"]:
        _write_pages(published())
        return 0
    if unknown := set(arguments) - set(scene_names()):
        say(f"no such scene in the library: {', '.join(sorted(unknown))}")
        return 2
    names = tuple(arguments) or scene_names()
    moved = _publish(names)
    say(f"{FOLDER.name}: {len(names)} scenes, {moved} moved; look at `git diff` before you commit")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
