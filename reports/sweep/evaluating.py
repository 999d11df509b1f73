"""From one point to its figures: the engines on the bodies that its group shares, and as much of the comparison as is asked for."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

from reports.sweep.figures import fields_needed, is_metric, own_doubts, take
from scenes import ContactSolution, ConvergenceError, Friction, PolygonLoad, Scene
from scenes.scene import WORDS

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution, SolverSettings
    from halfplane_fe.scales import Scales
    from meshes import MeshSettings
    from reports.comparison.metrics import Metric


@dataclass(frozen=True)
class Asked:
    """What is asked of every point of a task."""

    engines: tuple[str, ...]
    figures: tuple[str, ...]
    uncertainty: str
    share: bool


@dataclass(frozen=True)
class Question:
    """One point: the scene and how it is cut and iterated."""

    scene: Scene
    mesh: MeshSettings
    solver: SolverSettings


Values = dict[str, float | None]


def exact_alone(asked: Asked, scene: Scene) -> ContactSolution:
    """Half-plane theory on its own points and instants of the steady cycle, no field more than the figures need."""
    import semi_analytic

    return semi_analytic.solve(scene, cycles="steady", fields=fields_needed(asked.figures))


@dataclass(frozen=True)
class Evaluated:
    """Figures by name, why some have no value, what the solution itself says of how uncertain some are; the notes of theory."""

    values: Values
    notes: dict[str, str]
    doubts: dict[str, float]
    of_theory: tuple[str, ...]


def evaluate(asked: Asked, scene: Scene, fe: ContactSolution, *, polygon: bool = False) -> Evaluated:
    """Every figure that is asked for; against theory on the polygon of the steps if wanted."""
    import semi_analytic

    metrics = [name for name in asked.figures if is_metric(name)]
    exact = None
    if "exact" in asked.engines:
        fields = semi_analytic.FIELDS if metrics else fields_needed(asked.figures)
        exact = semi_analytic.solve(scene, x=fe.x, time=fe.time, straight_steps=polygon, fields=fields)
    found = take(asked.figures, fe, exact)
    values, notes, doubts = dict(found.values), dict(found.notes), own_doubts(asked.figures, fe, exact)
    if metrics and exact is not None:
        from reports.comparison import compare

        straight = None
        if not polygon and {"dissipation_polygon", "dissipation_step"} & set(metrics):
            straight = semi_analytic.solve(scene, x=fe.x, time=fe.time, straight_steps=not fe.thinned)
        comparison = compare(exact, fe, polygon_reference=straight)
        for name in metrics:
            metric = comparison.metric(name)
            values[name] = metric.value
            doubts[name] = _stated(metric, fe, comparison.scales.half_width)
            if metric.value is None:
                notes[name] = metric.note or "there is nothing to compare"
    of_theory = tuple(f"half-plane theory: {note}" for note in exact.record.notes) if exact is not None else ()
    return Evaluated({name: values[name] for name in asked.figures}, notes, doubts, of_theory)


def _stated(metric: Metric, fe: ContactSolution, half_width: float) -> float:
    """What the result says of a metric's uncertainty: the metric's own, or that of the edges at its instant over a_ref; or 0."""
    doubts = [metric.uncertainty or 0.0]
    edges = getattr(fe, f"{metric.key}_uncertainty", None)
    if edges is not None and metric.time is not None:
        doubts.append(float(max(edges[int(abs(fe.time - metric.time).argmin())])) / half_width)
    return max(doubt for doubt in doubts if math.isfinite(doubt))


def finite_elements(asked: Asked, question: Question) -> tuple[FiniteElementSolution, dict[str, str]]:
    """The solution, on the bodies that its whole group shares if wanted; where these don't hold the contact, on its own."""
    import halfplane_fe

    scene, mesh, solver = question.scene, question.mesh, question.solver
    if not asked.share:
        return halfplane_fe.solve(scene, mesh, solver), {}
    scales = _shared_scales(scene)
    try:
        return halfplane_fe.solve(scene, mesh, solver, scales=scales), {}
    except ConvergenceError as failure:
        if "reached the end of the meshed side" not in str(failure):
            raise
    return halfplane_fe.solve(scene, mesh, solver), {
        "": "the contact left the side that its group shares; solved on bodies of its own"
    }


def _shared_scales(scene: Scene) -> Scales:
    """Those of the same bodies under the largest load alone, without friction: one for a group, whichever points it has."""
    from halfplane_fe.scales import largest_load

    changed = {
        "friction": Friction(coefficient=0.0),
        "load": PolygonLoad(initial_loading=((largest_load(scene), 0.0),)),
        "cycles": 1,
    }
    # Words move no number, and would keep points of one group apart.
    words = {name: Scene.model_fields[name].get_default(call_default_factory=True) for name in WORDS}
    still = scene.vary(**(words | changed))
    return _scales_of(still.model_dump_json())


@lru_cache(maxsize=256)
def _scales_of(scene: str) -> Scales:
    from halfplane_fe.scales import find_scales

    return replace(find_scales(Scene.model_validate_json(scene), Counter()), inner=0.0)
