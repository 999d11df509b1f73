"""The verdict of a run for programs: one JSON document on stdout; the whole of it is in comparison.json."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from reports.budget_words import honest_of
from reports.summary import strict
from reports.wording import lead, verdict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.expected import Finding
    from reports.jobs import Report

FORMAT = "halfplane verdict 1"


def verdict_json(report: Report, findings: Sequence[Finding], exit_code: int) -> str:
    """Verdict, headline metrics, expected numbers, page and times; strict JSON."""
    from reports import expected

    comparison = report.comparison
    content: dict[str, Any] = {
        "format": FORMAT,
        "scene": comparison.scene.name,
        "exit_code": exit_code,
        "passed": comparison.passed,
        "accurate": comparison.accurate,
        "admissible": comparison.admissible,
        "honest": comparison.honest,
        "lead": lead(comparison),
        "sentence": verdict(comparison),
        "metrics": {
            metric.key: {
                "value": metric.value,
                "uncertainty": metric.uncertainty,
                "unit": metric.unit,
                "tolerance": metric.tolerance,
                "accurate": metric.accurate,
                "honest": {"yes": True, "no": False}.get(honest_of(comparison, metric)),
            }
            for metric in comparison.headlines
        },
        "expected": expected.content(findings),
        "notes": comparison.notes,
        "page": str(report.page),
        "seconds": report.seconds,
    }
    return json.dumps(strict(content), allow_nan=False, indent=1, ensure_ascii=False)


def failure_json(scene: str, message: str, exit_code: int) -> str:
    """What is said of a run that did not converge."""
    return json.dumps({"format": FORMAT, "scene": scene, "exit_code": exit_code, "passed": False, "error": message}, indent=1)
