"""comparison.json: all that a report holds, as strict JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from reports.charts.templating import in_template
from reports.comparison.budget_words import budget_content, is_covered
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
    comparison and its error budget. Of an external result it also holds what was guessed about the
    file, how its columns were read, what its rows show (`evidence`), likely causes (`diagnoses`),
    and the study of several meshes. `comparison.why` is the difference of the dissipation split by
    causes. `unscored` are metrics with a tolerance and no value. What is not there is None or
    empty.
    """
    comparison = report.comparison
    budget = report.budget  # None where no error budget was measured
    scales = comparison.scales
    # The solutions that hold every instant of the scene. An external result may have few instants,
    # and then the reference beside it is solved at these alone.
    complete_solutions: tuple[ContactSolution, ...] = ()
    if not names_of_derived_fields(comparison.result):
        complete_solutions = (comparison.reference, comparison.result)
    verdicts = {
        name: getattr(comparison, name) for name in ("passed", "accurate", "verdict", "admissible")
    }
    unscored_keys = [metric.key for metric in comparison.unscored]
    return {
        "format": _FORMAT,
        **common_content(report),
        "profile_fit": fit_content(comparison.scene),
        "verdict": {
            **verdicts,
            "unscored": unscored_keys,
            "judged": sentence_on_judging(comparison, has_budget=budget is not None),
            "honest": report.coverage_in_words,
            "sentence": verdict_in_sentences(comparison),
        },
        "scales": {
            "P_ref": scales.normal_load,
            "a_ref": scales.half_width,
            "p_ref": scales.pressure,
            "f p_ref": scales.shear,
            "A": scales.compliance,
            "A f^2 P_ref^2": scales.dissipation,
        },
        "metrics": {
            metric.key: metric_content(metric, comparison.scene, is_covered(budget, metric))
            for metric in comparison.metrics
        },
        "budget": None if budget is None else budget_content(budget),
        "why": None if comparison.why is None else comparison.why.content(),
        "inputs": content_of_report(report),
        "expected": expected_content(expected_numbers(comparison.scene, complete_solutions)),
        "instants": comparison.result_cycle.time,
        "reference": solution_content(comparison.reference, comparison.reference_certificates),
        "result": solution_content(comparison.result, comparison.result_certificates),
        "polygon_reference": (
            solution_content(comparison.polygon_reference, ())
            if comparison.polygon_reference
            else None
        ),
        "measured": record_content(comparison.scene),
        "interpolation": comparison.reference_cycle.interpolation_errors,
        "notes": comparison.notes,
        "guesses": report.guesses,
        "read_as": report.read_as,
        "evidence": [asdict(step) for step in report.evidence],
        "diagnoses": [asdict(diagnosis) for diagnosis in report.diagnoses],
        "study": report.study.content() if report.study else None,
        "seconds": seconds,
        "command": command,
        "scene": comparison.scene.model_dump(mode="json"),
    }
