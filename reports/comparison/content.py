"""comparison.json: the whole verdict as strict JSON (no NaN, no infinity)."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from reports.comparison import Comparison, Report, expected
from reports.comparison.cycles import last_cycle
from reports.comparison.laws import Certificate, derived
from reports.comparison.metrics import Metric, bulk_work
from reports.comparison.words import content, honest_of, said, verdict_content
from reports.measured import content as cycles_content
from reports.measured import record_content
from reports.profile_fit import content as fit_content
from scenes import ContactSolution

FORMAT = "halfplane comparison 2"


def as_json(report: Report, command: str = "", seconds: Mapping[str, float] | None = None) -> str:
    """A report as JSON text; what is not finite becomes null, its metric says "finite": false."""
    return json.dumps(strict(whole_content(report, command, seconds or {})), allow_nan=False, indent=1, ensure_ascii=False)


def strict(value: Any) -> Any:
    """`value` with numpy types as Python's and every NaN or infinity as None.

    >>> strict({"a": np.float64(1), "b": [float("nan"), np.int64(2)]})
    {'a': 1.0, 'b': [None, 2]}
    """
    if isinstance(value, Mapping):
        return {str(key): strict(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return strict(value.tolist())
    if isinstance(value, (list, tuple)):
        return [strict(entry) for entry in value]
    if isinstance(value, np.generic):
        return strict(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def whole_content(report: Report, command: str, seconds: Mapping[str, float]) -> dict[str, Any]:
    """All that comparison.json holds, by its names; numbers may be numpy's and not finite."""
    comparison = report.comparison
    scales = comparison.scales
    return {
        "format": FORMAT,
        **said(report),
        "profile_fit": fit_content(comparison.scene),
        "verdict": verdict_content(report),
        "scales": {
            "P_ref": scales.normal_load,
            "a_ref": scales.half_width,
            "p_ref": scales.pressure,
            "f p_ref": scales.shear,
            "A": scales.compliance,
            "A f^2 P_ref^2": scales.dissipation,
        },
        "metrics": {metric.key: _metric(metric, report) for metric in comparison.metrics},
        "budget": content(report.budget) if report.budget else None,
        "expected": expected.content(expected.check(comparison.scene, _own(comparison))),
        "instants": comparison.found.time,
        "reference": solution_content(comparison.reference, comparison.reference_certificates),
        "result": solution_content(comparison.result, comparison.result_certificates),
        "polygon_reference": solution_content(comparison.polygon_reference, ()) if comparison.polygon_reference else None,
        "measured": record_content(comparison.scene),
        "interpolation": comparison.expected.interpolation,
        "notes": comparison.notes,
        "guesses": report.guesses,
        "diagnoses": [asdict(one) for one in report.diagnoses],
        "study": report.study.content() if report.study else None,
        "seconds": seconds,
        "command": command,
        "scene": comparison.scene.model_dump(mode="json"),
    }


def _own(comparison: Comparison) -> tuple[ContactSolution, ...]:
    """The solutions that hold every instant of the scene: beside a foreign result both have its few only."""
    return () if derived(comparison.result) else (comparison.reference, comparison.result)


def _metric(metric: Metric, report: Report) -> dict[str, Any]:
    return {
        "label": metric.label,
        "value": metric.value,
        "finite": metric.value is None or math.isfinite(metric.value),
        "unit": metric.unit,
        "tolerance": metric.tolerance,
        "accurate": metric.accurate,
        "verdict": metric.verdict,
        "honest": {"yes": True, "no": False}.get(honest_of(report, metric)),
        "absolute": metric.absolute,
        "amounts": metric.amounts,
        "signed": metric.definition.signed,
        "headline": metric.definition.headline,
        "norm": metric.definition.norm,
        "region": metric.definition.region,
        "definition": metric.definition.text,
        "worst_at": metric.time,
        "worst_at_x_over_a_ref": metric.place,
        "uncertainty": metric.uncertainty,
        "elements": metric.elements,
        "spacings": metric.spacings,
        "note": metric.note,
        "series": metric.series,
    }


def of_bulk(solution: ContactSolution) -> dict[str, Any]:
    """What a solution with bulk stress, tilt or unequal sides has beside: ends of permanent stick, and the part of `loop_work` that
    is the bulk term, -closed integral of m_q d(eps) by the trapezoidal rule; nothing without.
    """
    if solution.permanent_stick_edges is None:
        return {}
    left, right = solution.permanent_stick_edges.tolist()
    whole = "whole_cycle" not in solution.work.skipped and len(solution.last_cycle) > 1
    term = bulk_work(last_cycle(solution), solution.scene.material) if whole else math.nan
    return {"bulk_work": term, "permanent_stick_left": left, "permanent_stick_right": right}


def solution_content(solution: ContactSolution, checks: tuple[Certificate, ...]) -> dict[str, Any]:
    """What is worth keeping of one solution beside its fields."""
    record, work = solution.record, solution.work
    return {
        "engine": solution.engine,
        "dissipation": solution.dissipation,
        "dissipation_uncertainty": solution.dissipation_uncertainty,
        "dissipation_drift": solution.dissipation_drift,
        "loop_work": solution.loop_work,
        **of_bulk(solution),
        "cycle_dissipation": solution.cycle_dissipation,
        "load_cycles": cycles_content(solution),
        "permanent_stick_half_width": solution.permanent_stick_half_width,
        "largest_half_width": np.nanmax(solution.contact_half_width),
        "largest_pressure": np.max(solution.pressure),
        "steady_from": solution.steady_from,
        "converged": record.converged,
        "termination": record.termination,
        "message": record.message,
        "notes": record.notes,
        "certificates": {
            check.label: {
                "value": check.value,
                "limit": check.limit,
                "holds": check.holds,
                "worst_at": check.time,
            }
            for check in checks
        },
        "counts": work.counts,
        "skipped": {name: {"count": count, "reason": reason} for name, (count, reason) in work.skipped.items()},
        "seconds": work.seconds,
        "mesh_quality": {
            name: dict(body.quality) for name, body in zip(("lower", "upper"), getattr(solution, "bodies", ()), strict=False)
        },
        "settings": solution.settings,
        "versions": solution.versions,
    }
