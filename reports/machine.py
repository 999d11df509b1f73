"""The verdict of a run for programs: one JSON document on stdout; the whole of it is in comparison.json."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from reports.budget_words import honest_of
from reports.summary import strict
from reports.verdicts import Verdict
from reports.wording import how_judged, lead, verdict

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from reports.checking import PathCheck
    from reports.doctor import Finding as Check
    from reports.expected import Finding
    from reports.fields_job import FieldsReport
    from reports.jobs import Report
    from reports.largest_contact import LargestContact
    from reports.maps.advice import Advice
    from reports.paper.page import PaperReport
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
        "verdict": comparison.verdict,
        "judged": how_judged(report.found),
        "admissible": comparison.admissible,
        "honest": report.found.honest,
        "lead": lead(report.found),
        "sentence": verdict(report.found),
        "metrics": {
            metric.key: {
                "value": metric.value,
                "uncertainty": metric.uncertainty,
                "unit": metric.unit,
                "tolerance": metric.tolerance,
                "accurate": metric.accurate,
                "verdict": metric.verdict,
                "honest": {"yes": True, "no": False}.get(honest_of(report.found, metric)),
            }
            for metric in comparison.headlines
        },
        "dissipation": comparison.result.dissipation,
        "dissipation_uncertainty": comparison.result.dissipation_uncertainty,
        "dissipation_drift": comparison.result.dissipation_drift,
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
    *("engine", "converged", "message", "notes", "dissipation", "dissipation_uncertainty", "dissipation_drift"),
    *("loop_work", "permanent_stick_half_width"),
    *("largest_half_width", "largest_pressure", "certificates", "counts"),
)


def check_json(
    scene: Scene, found: PathCheck, largest: LargestContact, words: Sequence[str], doubts: Sequence[str], sentence: str
) -> str:
    """What `check` says of a scene that can be solved; a peak pressure that is infinite is null."""
    worst = {"ratio": found.ratio, "part": found.part, "time": found.time, "normal_load": found.normal_load}
    return _text(
        {
            "format": FORMAT,
            "scene": scene.name,
            "exit_code": 0,
            "passed": True,
            "sentence": sentence,
            "notes": list(words),
            "remarks": list(doubts),
            "largest_contact": vars(largest),
            "nearest_to_sliding": worst | {"tangential_load": found.tangential_load},
        }
    )


def doctor_json(findings: Sequence[Check], code: int) -> str:
    """What the doctor found."""
    checks = {one.name: {"good": one.good, "found": one.found} for one in findings}
    return _text({"format": FORMAT, "exit_code": code, "passed": code == 0, "checks": checks})


def sweep_json(state: State, code: int = 0, **written: Path) -> str:
    """How far a sweep is, and what was `written`; `seconds_left` is null where no sweep is at work or no rate is known."""
    return _text({"format": FORMAT, "title": state.title, "exit_code": code, **_points(state), **_names(written)})


def _points(state: State) -> dict[str, Any]:
    counts = {name: getattr(state, name) for name in ("done", "failed", "running", "waiting", "total")}
    failures = [{"point": number, "reason": reason} for number, reason in state.failures]
    notes = [{"note": note, "points": count} for note, count in state.notes]
    return {"points": counts, "seconds_left": state.left, "damaged": state.damaged, "failures": failures, "notes": notes}


def _names(written: Mapping[str, Path]) -> dict[str, str]:
    return {name: str(path) for name, path in written.items()}


def maps_json(studies: Mapping[str, State], code: int, page: Path) -> str:
    """The studies that were run for a map, none where only pages were written, and the page that leads to all."""
    points = {name: _points(state) for name, state in studies.items()}
    return _text({"format": FORMAT, "exit_code": code, "passed": code == 0, "studies": points, "page": str(page)})


def advice_json(advice: Advice, sentence: str) -> str:
    """What the maps say: every departure (`errors` null where they know nothing), the sum of what is known, and the answer."""
    from reports.maps.advice import total
    from reports.maps.advising import FIGURES

    departures = [
        {
            "what": part.what,
            "errors": None if part.values is None else {_bare(name): _doubted(part.values[name]) for name in FIGURES},
            "extrapolated": part.extrapolated,
            "from": part.how,
        }
        for part in advice.parts
    ]
    return _text(
        {
            "format": FORMAT,
            "scene": advice.scene.name,
            "exit_code": advice.exit_code,
            "passed": advice.exit_code == 0,
            "sentence": sentence,
            "limit": advice.limit,
            "verdict": advice.verdict,
            "within_limit": None if advice.verdict is None else advice.verdict is Verdict.WITHIN,
            "extrapolated": advice.extrapolated,
            "contact_half_width": advice.half_width,
            "departures": departures,
            "sum_of_known": {_bare(name): _doubted(total(advice.known, name)) for name in FIGURES} if advice.known else None,
        }
    )


def _bare(figure: str) -> str:
    return figure.removeprefix("error.")


def _doubted(pair: tuple[float, float]) -> dict[str, float]:
    return {"error": pair[0], "uncertainty": pair[1]}


def fields_json(scene: Scene, report: FieldsReport, file: Path) -> str:
    """What `fields` wrote: every instant with its largest nodal stresses, what they are not, the files, the notes."""
    from reports.fields import NO_PEAK

    instants = [
        {
            "label": one.instant.label,
            "time": one.time,
            "normal_load": one.normal_load,
            "tangential_load": one.tangential_load,
            **{
                f"largest_nodal_{name}": {"value": found.value, "body": found.body, "place": list(found.place)}
                for name, found in (("von_mises", one.von_mises), ("tension", one.tension))
            },
        }
        for one in report.instants
    ]
    told = {"instants": instants, "largest nodal stresses": NO_PEAK, "notes": list(report.notes), "files": list(report.files)}
    more = {"file": str(file), "seconds": dict(report.seconds)}
    return _text({"format": FORMAT, "scene": scene.name, "exit_code": 0, "passed": True, **told, **more})


def paper_json(report: PaperReport, code: int, seconds: Mapping[str, float]) -> str:
    """Both tables of the paper: statements with verdicts, misprints with proofs (`proven` null: nothing to evaluate)."""
    from reports.paper.page import tally

    return _text(
        {
            "format": FORMAT,
            "exit_code": code,
            "passed": code == 0,
            "verdicts": tally(report.statements),
            "statements": [vars(row) for row in report.statements],
            "misprints": [vars(row) for row in report.misprints],
            "page": str(report.page),
            "seconds": dict(seconds),
        }
    )


def deck_json(scene: Scene, figures: Mapping[str, Any], file: Path, seconds: Mapping[str, float]) -> str:
    """What an exported deck holds, and where it is."""
    more = {"file": str(file), "seconds": dict(seconds)}
    return _text({"format": FORMAT, "scene": scene.name, "exit_code": 0, "passed": True, **figures, **more})


def _text(content: dict[str, Any]) -> str:
    return json.dumps(strict(content), allow_nan=False, indent=1, ensure_ascii=False)
