"""The verdict of a run for programs: one JSON document on stdout; the whole of it is in comparison.json."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from reports.budget_words import honest_of
from reports.summary import strict
from reports.wording import lead, verdict

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from reports.checking import PathCheck
    from reports.doctor import Finding as Check
    from reports.expected import Finding
    from reports.jobs import Report
    from reports.sweep.progress import State
    from scenes import ContactSolution, Scene

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
    return _text(content)


def failure_json(scene: str, message: str, exit_code: int, kept: Path | None) -> str:
    """What is said of a run that did not converge; `file` holds the steps solved until then, null if there are none."""
    file = None if kept is None else str(kept)
    return _text({"format": FORMAT, "scene": scene, "exit_code": exit_code, "passed": False, "error": message, "file": file})


def solution_json(
    solution: ContactSolution, findings: Sequence[Finding], file: Path, seconds: Mapping[str, float], code: int
) -> str:
    """What is said of one engine alone: its figures, the laws of contact, the expected numbers."""
    from reports import expected
    from reports.certificates import certificates
    from reports.single import is_admissible
    from reports.summary import solution_content

    whole = solution_content(solution, certificates(solution))
    return _text(
        {
            "format": FORMAT,
            "scene": solution.scene.name,
            "exit_code": code,
            "passed": code == 0,
            "admissible": is_admissible(solution),
            **{key: whole[key] for key in _ALONE},
            "expected": expected.content(findings),
            "file": str(file),
            "seconds": dict(seconds),
        }
    )


_ALONE = (
    *("engine", "converged", "message", "notes", "dissipation", "loop_work", "permanent_stick_half_width"),
    *("largest_half_width", "largest_pressure", "certificates", "counts"),
)


def check_json(scene: Scene, found: PathCheck, words: Sequence[str], sentence: str) -> str:
    """What `check` says of an admissible scene."""
    worst = {"ratio": found.ratio, "part": found.part, "time": found.time, "normal_load": found.normal_load}
    return _text(
        {
            "format": FORMAT,
            "scene": scene.name,
            "exit_code": 0,
            "passed": True,
            "sentence": sentence,
            "notes": list(words),
            "nearest_to_sliding": worst | {"tangential_load": found.tangential_load},
        }
    )


def doctor_json(findings: Sequence[Check], code: int) -> str:
    """What the doctor found."""
    checks = {one.name: {"good": one.good, "found": one.found} for one in findings}
    return _text({"format": FORMAT, "exit_code": code, "passed": code == 0, "checks": checks})


def sweep_json(state: State) -> str:
    """How far a sweep is; `seconds_left` is null where no sweep is at work or no rate is known."""
    counts = {name: getattr(state, name) for name in ("done", "failed", "running", "waiting", "total")}
    failures = [{"point": number, "reason": reason} for number, reason in state.failures]
    more = {"seconds_left": state.left, "damaged": state.damaged, "failures": failures}
    return _text({"format": FORMAT, "title": state.title, "exit_code": 0, "points": counts, **more})


def _text(content: dict[str, Any]) -> str:
    return json.dumps(strict(content), allow_nan=False, indent=1, ensure_ascii=False)
