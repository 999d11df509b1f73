"""The page: one self-contained HTML file that works offline."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from reports.charts.plate import STATE_KEYS, Plate
from reports.charts.templating import script, template
from reports.comparison import Comparison, Report
from reports.comparison.cycles import last_cycle
from reports.comparison.metrics import Metric, Verdict, bulk_work, name_of, normal_work
from reports.comparison.words import (
    SUPPORT_WORDS,
    THEORY,
    cost,
    first_table,
    heads,
    honesty,
    how_judged,
    lead,
    narrow,
    rows,
    said,
    sentence,
    shown,
    standing,
    tolerance_of,
    uncertain_work,
    uncertainty_of,
    unit_of,
    value_of,
    verdict,
    without_cycle,
)
from reports.measured import section
from reports.page.live import as_script, carried
from reports.profile_fit import findings
from reports.units import energy_unit, minus, signed, units
from scenes import ContactSolution


def render(
    report: Report,
    drawings: Sequence[Plate],
    command: str,
    seconds: Mapping[str, float],
    live: Mapping[str, Any] | None = None,
    third: Mapping[str, Any] | None = None,
) -> str:
    """The HTML text; every word that came from outside is escaped, and no script but the page's own may run.

    Parameters
    ----------
    drawings : the figures; one that is missing leaves its place empty
    command : what reproduces the page
    seconds : stage -> wall time
    live : what the slider moves through; without it the page has none
    third : words of the third solver, where it ran
    """
    comparison = report.comparison
    scene = comparison.scene
    words = said(report)
    program, digest = script()
    return template("report.html").render(
        title=scene.title or scene.name,
        scene=scene,
        **words | {"bodies": [words["bodies"], words["unlike_materials"], *findings(scene)[0]]},
        columns=first_table(report)[0],
        lead=lead(report),
        standing=standing(comparison),
        judged=how_judged(report),
        meshes=_meshes(comparison.result),
        verdict=verdict(report),
        comparison=comparison,
        report=report,
        rows=[_row(metric) for metric in comparison.headlines],
        others=[_row(metric) for metric in comparison.others],
        claims=_claims(report),
        budget=_budget(report),
        notes=_notes(comparison),
        scales=_scales(comparison),
        energy=energy_unit(scene),
        dissipations=_dissipations(comparison),
        pulled=comparison.pulled,
        measured=section(scene, (comparison.reference, comparison.result)),
        checks=[
            (name_of(comparison.reference.engine), comparison.reference_certificates),
            (name_of(comparison.result.engine), comparison.result_certificates),
        ],
        figures={drawing.name: drawing for drawing in drawings},
        engines=[_engine(comparison.reference), _engine(comparison.result)],
        command=command,
        commit=commit(),
        paper=THEORY,
        own=partial(without_cycle, scene=scene),
        third=third,
        script=program,
        script_hash=digest,
        live=as_script(dict(live) if live else {"instants": 0}),
        carried=carried(dict(live)) if live else "",
        states=STATE_KEYS,
        sentence=sentence,
        step_errors=list(_step_errors(comparison)),
        seconds=seconds,
    )


def commit() -> str:
    """The commit of the checkout that this package lies in, "with changes" where files differ from it; or why there is none."""
    home = Path(__file__).parents[2]
    if not (home / ".git").exists():
        return "installed without its history"
    words = ["git", "-C", str(home), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return "unknown: git does not answer"
    return done.stdout.strip().replace("-dirty", ", with changes")


def _row(metric: Metric) -> dict[str, str]:
    """A line of the table of all metrics."""
    return {
        "label": metric.label,
        "value": value_of(metric),
        "unit": unit_of(metric),
        "tolerance": tolerance_of(metric),
        "accurate": metric.verdict or "–",
        "when": "" if metric.time is None else signed(metric.time),
        "where": "" if metric.place is None else signed(metric.place),
        "uncertainty": uncertainty_of(metric),
        "note": metric.note,
        "norm": metric.definition.norm,
        "region": metric.definition.region,
        "definition": metric.definition.text,
    }


def _budget(report: Report) -> dict[str, Any] | None:
    """Where the errors come from: tables of the headlines and of the rest, what each term rests on, and the cost."""
    if report.budget is None:
        return None
    found = report.budget
    first, others = rows(found), rows(found, headline=False)
    columns, both = narrow(heads(found), [*first, *others])
    return {
        "heads": columns,
        "rows": both[: len(first)],
        "others": both[len(first) :],
        "how": [(one.metric.label, [(term.name, term.how) for term in one.terms]) for one in found.budgets],
        "cost": cost(found),
    }


def _claims(report: Report) -> list[tuple[str, str, str]]:
    """The three claims: name, answer (yes, no, undecided or not assessed), and what it rests on."""
    comparison, answers = report.comparison, {True: "yes", False: "no", None: "not assessed"}
    checks = (*comparison.reference_certificates, *comparison.result_certificates)
    judged = [metric.verdict for metric in comparison.metrics if metric.verdict is not None]
    undecided = judged.count(Verdict.UNDECIDED)
    return [
        (
            "Admissible",
            answers[comparison.admissible],
            f"{sum(check.holds for check in checks)} of {len(checks)} checks of the laws of contact hold, which need no reference",
        ),
        (
            "Accurate",
            {Verdict.UNDECIDED: "undecided", None: "not assessed"}.get(comparison.verdict, answers[comparison.accurate]),
            f"{judged.count(Verdict.WITHIN)} of {len(judged)} metrics that have a tolerance lie within it"
            + (f"; {undecided} undecided, which counts as outside" if undecided else ""),
        ),
        ("Honest", answers[honesty(report)], report.honest.removeprefix("not assessed: ")),
    ]


def _notes(comparison: Comparison) -> list[str]:
    """What a reader must not miss: of the metrics, then of the solutions."""
    named = [(m.label, m.note) for m in comparison.headlines if m.note]
    own = [sentence(note if note.lower().startswith(label.lower()) else f"{label}: {note}") for label, note in named]
    return [*own, *comparison.notes]


def _scales(comparison: Comparison) -> list[tuple[str, str, str]]:
    force, length, stress = units(comparison.scene)
    scales = comparison.scales
    return [
        (
            "P_ref",
            f"{scales.normal_load:.6g} {force}/{length}",
            "mean load of an ellipse, else the largest of the last cycle",
        ),
        ("a_ref", f"{scales.half_width:.6g} {length}", "half-width of the reference at P_ref"),
        ("p_ref", f"{scales.pressure:.6g} {stress}", "2 P_ref/(π a_ref)"),
        (
            "A f² P_ref²",
            f"{scales.dissipation:.6g} {energy_unit(comparison.scene)}",
            "scale of the dissipation of a cycle; A = 2/E*",
        ),
    ]


def _dissipations(comparison: Comparison) -> list[dict[str, str]]:
    """Dissipation of each solution: both routes and every cycle."""
    polygon = comparison.polygon_reference
    solutions = [
        (name_of(comparison.reference.engine), comparison.reference),
        *([(f"{name_of(polygon.engine)}, on the polygon of the steps", polygon)] if polygon else []),
        (name_of(comparison.result.engine), comparison.result),
    ]
    return [
        {
            "name": name,
            "value": _figure(solution.dissipation, "8g"),
            "scaled": _figure(solution.dissipation / comparison.scales.dissipation, "8g"),
            "loop": "–" if np.isnan(solution.loop_work) else minus(f"{solution.loop_work:.8g}"),
            # Of the instants that the solution has.
            "bulk": minus(f"{bulk_work(last_cycle(solution), solution.scene.material):.8g}"),
            "normal": "–" if (work := normal_work(solution)) is None else minus(f"{work:.8g}"),
            "apart": _apart(solution),
            "cycles": ", ".join(_figure(w, "6g") for w in solution.cycle_dissipation),
        }
        for name, solution in solutions
    ]


def _figure(value: float, form: str) -> str:
    """A number, or a dash for what a solution does not hold."""
    return "–" if np.isnan(value) else format(value, f".{form}")


def _step_errors(comparison: Comparison) -> Iterator[str]:
    """What W is uncertain by at least, and what friction work at the end of each step would make of it: the step's own error."""
    if words := uncertain_work(comparison):
        yield words
    for solution in (comparison.reference, comparison.result):
        energy = solution.record.energy
        if {"interface", "end_of_step"} <= energy.keys() and solution.dissipation > 0:
            steps = solution.last_cycle[1:]
            excess = float((energy["end_of_step"] - energy["interface"])[steps].sum()) / solution.dissipation
            yield (
                f"{name_of(solution.engine).capitalize()}: with the tractions at the end of each step instead of their mean "
                f"the interface work of the cycle would differ by {shown(excess)} of W."
            )


def _apart(solution: ContactSolution) -> str:
    """How far the work of the loads is from the dissipation."""
    if np.isnan(solution.loop_work) or not solution.dissipation:
        return "–"
    return minus(f"{abs((solution.loop_work + (normal_work(solution) or 0.0)) / solution.dissipation - 1):.1e}")


def _meshes(solution: ContactSolution) -> list[dict[str, str]]:
    """Quality record of each body's mesh; none where the result has no bodies."""
    return [
        {
            "name": name,
            "elements": f"{body.quality['elements']:.0f}",
            "nodes": f"{body.quality['nodes']:.0f}",
            "least_angle": f"{body.quality['least_angle']:.1f}°",
            "worst_shape": f"{body.quality['worst_shape']:.3f}",
            "size_ratio": f"{body.quality['size_ratio']:.3g}",
            "area_error": minus(f"{body.quality['area_error']:.1e}"),
            "supports": "; ".join(
                f"{boundary.replace('_', ' ')} {SUPPORT_WORDS[support]}" for boundary, support in body.supports.items()
            ),
        }
        for name, body in zip(("lower", "upper"), getattr(solution, "bodies", ()), strict=False)
    ]


def _engine(solution: ContactSolution) -> dict[str, Any]:
    return {
        "name": name_of(solution.engine),
        "message": sentence(solution.record.message),
        "steps": len(solution.time),
        "points": len(solution.x),
        "counts": {name.replace("_", " "): count for name, count in solution.work.counts.items()},
        "seconds": solution.work.seconds,
        "skipped": solution.work.skipped,
        "settings": flat(solution.settings),
        "versions": solution.versions,
    }


def flat(settings: Mapping[str, Any], above: str = "") -> dict[str, str]:
    """Nested settings as one list, names joined by dots, numbers to six digits.

    >>> flat({"mesh": {"order": 2}, "element_size": 0.0144202817})
    {'mesh.order': '2', 'element_size': '0.0144203'}
    """
    found: dict[str, str] = {}
    for name, value in settings.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{above}{name}.")
        else:
            found[above + name] = f"{value:.6g}" if isinstance(value, float) else str(value)
    return found
