"""The numbers that a scene expects beside what an engine found."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from reports.comparison.metrics import Verdict, energy_scale, name_of, verdict_on
from reports.units import minus
from scenes import ContactSolution, Expected, Scene


@dataclass(frozen=True)
class Finding:
    """An expected number and what was found in its place.

    Attributes
    ----------
    expected : the number, its tolerance, engine and source
    found : the engine's own; NaN where it has no such thing
    difference : found less expected, in the measure of the tolerance
    """

    expected: Expected
    found: float
    difference: float

    @property
    def met(self) -> bool:
        """Whether the difference lies within the tolerance; a NaN never does."""
        return verdict_on(self.difference, self.expected.tolerance) is Verdict.WITHIN


def measure(solution: ContactSolution, quantity: str) -> float:
    """A quantity of `Expected` in the last cycle of an answer, in the scene's units; NaN where there is no such thing.

    The half-plane engine answers on its own points; the pressure is the largest of those.
    """
    return _MEASURES[quantity](solution)


def _largest_half_width(solution: ContactSolution) -> float:
    return float(np.nanmax(solution.contact_half_width[solution.last_cycle]))


def _lower_face_displacement(solution: ContactSolution) -> float:
    """u_y of the middle of the lower face at the largest load; NaN for a half-plane, whose displacement has no datum."""
    from halfplane_fe import FiniteElementSolution, fields

    if not isinstance(solution, FiniteElementSolution) or solution.scene.bodies.lower.kind == "half_plane":
        return math.nan
    largest = solution.last_cycle[np.argmax(solution.normal_load[solution.last_cycle])]
    lower = fields(solution, [solution.time[largest]])[0].bodies[0]
    middle = np.argmin(np.hypot(*lower.points.T))
    return float(lower.displacement[middle, 1])


def _stick_centre(solution: ContactSolution) -> float:
    edges = solution.permanent_stick_edges
    return math.nan if edges is None else float(np.mean(edges))


def _moment(solution: ContactSolution) -> float:
    """At the largest load of the last cycle."""
    largest = solution.last_cycle[np.argmax(solution.normal_load[solution.last_cycle])]
    return math.nan if solution.moment is None else float(solution.moment[largest])


_MEASURES: dict[str, Callable[[ContactSolution], float]] = {
    "dissipation": lambda solution: float(solution.dissipation),
    "loop_work": lambda solution: float(solution.loop_work),
    "largest_half_width": _largest_half_width,
    "least_half_width": lambda solution: float(np.nanmin(solution.contact_half_width[solution.last_cycle])),
    "largest_pressure": lambda solution: float(np.max(solution.pressure[solution.last_cycle])),
    "permanent_stick_half_width": lambda solution: float(solution.permanent_stick_half_width),
    "stick_share": lambda solution: float(solution.permanent_stick_half_width) / _largest_half_width(solution),
    "stick_centre": _stick_centre,
    "contact_left": lambda solution: float(np.nanmin(solution.contact_edges[solution.last_cycle, 0])),
    "contact_right": lambda solution: float(np.nanmax(solution.contact_edges[solution.last_cycle, 1])),
    "moment": _moment,
    "lower_face_displacement": _lower_face_displacement,
}


def scale(expected: Expected, solution: ContactSolution) -> float:
    """What the tolerance is relative to: the value, or where that is 0 the scale of its kind."""
    if expected.value:
        return abs(expected.value)
    match expected.quantity:
        case "dissipation" | "loop_work":
            load = float(solution.normal_load[solution.last_cycle].max())
            return energy_scale(solution.scene, load)
        case "largest_pressure":
            return float(np.max(solution.pressure))
        case "stick_share":
            return 1.0
    return _largest_half_width(solution)


def check(scene: Scene, solutions: Iterable[ContactSolution]) -> Iterator[Finding]:
    """The numbers that `scene` expects of these engines, in its order; those of other engines are left out."""
    answers = {name_of(solution.engine): solution for solution in solutions}
    for expected in scene.expected:
        if expected.engine in answers:
            solution = answers[expected.engine]
            found = measure(solution, expected.quantity)
            yield Finding(expected, found, (found - expected.value) / scale(expected, solution))


def rows(findings: Iterable[Finding]) -> list[tuple[str, ...]]:
    """Cells of the table that the terminal shows, under `HEADS`."""
    return [
        (
            one.expected.quantity.replace("_", " "),
            one.expected.engine,
            f"{one.expected.value:.5g}",
            "none" if math.isnan(one.found) else f"{one.found:.5g}",
            "–" if math.isnan(one.difference) else minus(f"{one.difference:+.1e}"),
            f"{one.expected.tolerance:.3g}",
            "yes" if one.met else "no",
        )
        for one in findings
    ]


HEADS = ("quantity", "engine", "expected", "found", "off", "limit", "met")


def content(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    """The same for JSON."""
    return [
        {**one.expected.model_dump(mode="json"), "found": one.found, "difference": one.difference, "met": one.met}
        for one in findings
    ]
