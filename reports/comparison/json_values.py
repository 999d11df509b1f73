"""Solutions and metrics as JSON: what comparison.json and the answer of one engine hold of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from reports.comparison.laws import Certificate, values_of_unsymmetric
from reports.comparison.metrics import Metric
from reports.comparison.words import text_on_part_of_path
from reports.measured import load_cycles
from scenes import ContactSolution, Scene


def strict_json_values(value: Any) -> Any:
    """`value` for JSON: numpy types as Python's, and every NaN or infinity as None, in nested
    mappings and lists too.

    >>> strict_json_values({"a": np.float64(1), "b": [float("nan"), np.int64(2)]})
    {'a': 1.0, 'b': [None, 2]}
    """
    if isinstance(value, Mapping):
        return {str(key): strict_json_values(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return strict_json_values(value.tolist())
    if isinstance(value, list | tuple):
        return [strict_json_values(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


# Fields of a metric that its JSON holds under the same names.
_FIELDS_OF_METRIC = (
    "label",
    "value",
    "unit",
    "tolerance",
    "accurate",
    "verdict",
    "absolute",
    "amounts",
    "stated",
    "uncertainty",
    "elements",
    "note",
    "series",
    "signed",
    "headline",
    "why",
)


def metric_content(metric: Metric, scene: Scene, is_covered: bool | None) -> dict[str, Any]:
    """A metric of a comparison, as JSON values by key: its numbers, verdict and texts; whether its
    value is finite or missing ("finite"); the instant and place of its worst error, x over the
    half-width at the reference load (a_ref).

    `is_covered`: whether its stated uncertainty covers its known error, None where that is not
    known. Texts on the last cycle are changed to the whole path where the loads of `scene` do not
    repeat: "norm" (how errors at points become one value), "region" (which points count).
    """
    # _FIELDS_OF_METRIC: names of attributes that JSON holds as they are, such as "label", "value"
    return {
        **{name: getattr(metric, name) for name in _FIELDS_OF_METRIC},
        "norm": text_on_part_of_path(metric.norm, scene),
        "region": text_on_part_of_path(metric.region, scene),
        "definition": text_on_part_of_path(metric.how, scene),
        "finite": metric.value is None or math.isfinite(metric.value),
        "honest": is_covered,
        "worst_at": metric.time,
        "worst_at_x_over_a_ref": metric.place,
    }


def solution_content(solution: ContactSolution, checks: tuple[Certificate, ...]) -> dict[str, Any]:
    """A solution without its fields, for JSON: energies, largest half-width and pressure,
    convergence, laws of contact, counts of work, settings. `checks` are the results of checking the
    laws of contact: largest violation, its limit, its time. Energies are per unit thickness.

    Beside them, where there are any: work and stick ends of scenes with bulk stress or tilt, load
    cycles of measured loads, and quality of the finite-element meshes.
    """
    names_of_values = (
        "engine",
        "dissipation",
        "dissipation_uncertainty",
        "uncertainties",
        "dissipation_drift",
        "loop_work",
        "cycle_dissipation",
        "permanent_stick_half_width",
        "steady_from",
        "settings",
        "versions",
    )
    # how the solve went: solution.record
    names_in_record = ("converged", "termination", "message", "notes")
    # meshed bodies; none in a solution that is not of finite elements, or was read from a file
    bodies = zip(("lower", "upper"), getattr(solution, "bodies", ()), strict=False)
    # counted in a table of measured loads; None for other loads
    cycles = load_cycles(solution) if solution.scene.has_measured_rows else None
    return {
        **{name: getattr(solution, name) for name in names_of_values},
        **values_of_unsymmetric(solution),
        "load_cycles": cycles.content() if cycles else None,
        "largest_half_width": np.nanmax(solution.contact_half_width),
        "largest_pressure": np.max(solution.pressure),
        **{name: getattr(solution.record, name) for name in names_in_record},
        "certificates": {
            check.label: {
                "value": check.value,
                "limit": check.limit,
                "holds": check.holds,
                "worst_at": check.time,
            }
            for check in checks
        },
        "counts": solution.work.counts,
        "skipped": {
            name: {"count": count, "reason": reason}
            for name, (count, reason) in solution.work.skipped.items()
        },
        "seconds": solution.work.seconds,
        "mesh_quality": {body_name: dict(body.quality) for body_name, body in bodies},
    }
