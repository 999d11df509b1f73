"""comparison.json: all that a report holds, as strict JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from reports.charts.templating import in_template
from reports.comparison import Comparison
from reports.comparison.budget_words import budget_content
from reports.comparison.json_values import metric_content, solution_content, strict_json_values
from reports.comparison.laws import expected_content, expected_numbers, names_of_derived_fields
from reports.comparison.words import (
    bodies_in_words,
    first_table,
    question_in_words,
    sentence_beyond_theory,
    sentence_on_judging,
    unlike_materials_in_words,
    verdict_in_sentences,
)
from reports.input_words import content_of_report
from reports.measured import record_content
from reports.profile_fit import content as fit_content
from reports.report import Report
from scenes import ContactSolution

_FORMAT = "halfplane comparison 2"


def as_json(report: Report, command: str = "", seconds: Mapping[str, float] | None = None) -> str:
    """A report as JSON text. A number that is not finite becomes null, with "finite": false in its
    metric. `command` reproduces the report; `seconds` holds the wall time of each stage.
    """
    return json.dumps(
        strict_json_values(whole_content(report, command, seconds or {})),
        allow_nan=False,
        indent=1,
        ensure_ascii=False,
    )


def common_content(report: Report) -> dict[str, Any]:
    """What the page and comparison.json both hold, by its names there: the headline, the rows of
    the table of both solutions' values, and sentences on the scene, the bodies, the idealisation,
    and what a comparison of two codes can prove ("claim").
    """
    comparison = report.comparison
    scene = comparison.scene
    _, table_rows = first_table(comparison)
    # `in_template`: the text of that name in a template, filled with these values
    return {
        "headline": report.first_sentence,
        "table": table_rows,
        "claim": in_template("claim"),
        "question": question_in_words(scene),
        "bodies": bodies_in_words(scene),
        "unlike_materials": unlike_materials_in_words(scene),
        "idealisation": sentence_beyond_theory(comparison),
    }


def whole_content(report: Report, command: str, seconds: Mapping[str, float]) -> dict[str, Any]:
    """All that comparison.json holds, by its names; numbers may be numpy's and not finite.

    `command` reproduces the report; `seconds` holds the wall time of each stage. A report holds the
    comparison and its error budget, None where none was measured. `comparison.why` is the
    difference of the dissipation split by causes. What is not there is None or empty.
    """
    comparison = report.comparison
    scene = comparison.scene
    budget = report.budget
    return {
        "format": _FORMAT,
        **common_content(report),
        "profile_fit": fit_content(scene) if scene.has_measured_rows else None,
        "verdict": _verdict_content(report),
        "scales": _scales_content(comparison),
        "metrics": {
            metric.key: metric_content(metric, scene, report.is_covered(metric))
            for metric in comparison.metrics
        },
        "budget": None if budget is None else budget_content(budget),
        "why": None if comparison.why is None else comparison.why.content(),
        "inputs": content_of_report(report) if report.inputs else None,
        **_contents_of_solutions(comparison),
        "measured": record_content(scene) if scene.has_measured_rows else None,
        "interpolation": comparison.reference_cycle.interpolation_errors,
        "notes": comparison.notes,
        **_content_of_external_result(report),
        "seconds": seconds,
        "command": command,
        "scene": scene.model_dump(mode="json"),
    }


def _verdict_content(report: Report) -> dict[str, Any]:
    """The verdict as comparison.json states it: whether all metrics lie within their tolerances,
    and whether both solutions obey the laws of contact (`admissible`); with sentences on it.
    `unscored` are the keys of metrics with a tolerance and no value. "honest" states whether the
    uncertainties cover the differences.
    """
    comparison = report.comparison
    verdicts = {
        name: getattr(comparison, name) for name in ("passed", "accurate", "verdict", "admissible")
    }
    return {
        **verdicts,
        "unscored": [metric.key for metric in comparison.unscored],
        "judged": sentence_on_judging(comparison, has_budget=report.budget is not None),
        "honest": report.coverage_in_words,
        "sentence": verdict_in_sentences(comparison),
    }


def _scales_content(comparison: Comparison) -> dict[str, float]:
    """The scales of a comparison by their letters: load P_ref, half-width a_ref and peak pressure
    p_ref at the reference load; f the friction coefficient; A = 2/E* the compliance, E* the contact
    modulus; and the scale of dissipation.
    """
    scales = comparison.scales
    return {
        "P_ref": scales.normal_load,
        "a_ref": scales.half_width,
        "p_ref": scales.pressure,
        "f p_ref": scales.shear,
        "A": scales.compliance,
        "A f^2 P_ref^2": scales.dissipation,
    }


def _contents_of_solutions(comparison: Comparison) -> dict[str, Any]:
    """Entries of comparison.json on the solutions: the scene's expected numbers beside theirs, the
    instants that are compared, and a record of each solution with its certificates, which are
    checks of the laws of contact. `polygon_reference` is half-plane theory with straight loads
    between the instants of the result; None where it was not solved.

    An external result may have few instants, and then the reference beside it is solved at these
    alone. The expected numbers, which are of the whole path, are then compared with neither.
    """
    solutions_of_whole_path: tuple[ContactSolution, ...] = ()
    if not names_of_derived_fields(comparison.result):
        solutions_of_whole_path = (comparison.reference, comparison.result)
    return {
        "expected": expected_content(expected_numbers(comparison.scene, solutions_of_whole_path)),
        "instants": comparison.result_cycle.time,
        "reference": solution_content(comparison.reference, comparison.reference_certificates),
        "result": solution_content(comparison.result, comparison.result_certificates),
        "polygon_reference": (
            solution_content(comparison.polygon_reference, ())
            if comparison.polygon_reference
            else None
        ),
    }


def _content_of_external_result(report: Report) -> dict[str, Any]:
    """Entries of comparison.json on an external result: what was guessed about the file, how its
    columns were read, what its rows show (`evidence`), likely causes of the difference
    (`diagnoses`), and the study of several meshes. Empty lists and None for the project's own
    results.
    """
    return {
        "guesses": report.guesses,
        "read_as": report.read_as,
        "evidence": [asdict(step) for step in report.evidence],
        "diagnoses": [asdict(diagnosis) for diagnosis in report.diagnoses],
        "study": report.study.content() if report.study else None,
    }
