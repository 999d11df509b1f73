"""The runs beside a run from which its errors are measured: coarser meshes, other far fields, the law without a layer.

Rungs are compared with half-plane theory on the polygon of their own increments, so that no step error is in them. Sizes are over
those of the run.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from reports.comparison import Comparison, compare
from scenes import ContactSolution, ConvergenceError, InputError, Scene

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from halfplane_fe.scales import Scales
    from meshes import MeshSettings
    from reports.console import Report

# Of one stage: its name in, a context that yields report(done, total, text) out; `Stages.stage` is one.
Stage = Callable[[str], "AbstractContextManager[Report]"]

_LARGEST = 0.25  # of MeshSettings, over the contact half-width
_LEAST_RATIO = 1.2


@dataclass(frozen=True, eq=False)
class Rung:
    """One run of a ladder.

    Attributes
    ----------
    label : "2h", "L/2": what is different from the run
    size : that size over the run's; of the far field 1/L
    values : metric -> its value without the error of the steps; empty where the run failed
    failure : why there are none
    seconds : CPU time
    steps, nodes : of the path, of the contact
    """

    label: str
    size: float
    values: Mapping[str, float | None]
    failure: str = ""
    seconds: float = 0.0
    steps: int = 0
    nodes: int = 0


@dataclass(frozen=True, eq=False)
class Ladders:
    """Every rung by the term that it measures.

    Attributes
    ----------
    mesh : at h and coarser; far_field : at 2 L, L, L/2 on the coarse mesh, empty for bodies with a size of their own
    penalty : (with the layer, without) on the coarse mesh and on the one coarser still; empty where the law is met exactly
    coarse : label of the mesh on which all but the mesh ladder stand
    not_measured : term -> why
    seconds : CPU time of all rungs but the run's own
    """

    mesh: tuple[Rung, ...]
    far_field: tuple[Rung, ...]
    penalty: tuple[tuple[Rung, Rung], ...]
    coarse: str
    not_measured: Mapping[str, str]
    seconds: float


def without_steps(comparison: Comparison) -> dict[str, float | None]:
    """Metric -> value against theory on the polygon of the result's own increments."""
    if comparison.polygon_reference is None:
        raise InputError("a budget needs the reference on the polygon of the result's steps: give compare polygon_reference")
    return _values(compare(comparison.polygon_reference, comparison.result))


def _values(comparison: Comparison) -> dict[str, float | None]:
    return {metric.key: metric.value for metric in comparison.metrics}


def mesh_ratio(mesh: MeshSettings) -> float | None:
    """Ratio of neighbouring rungs: 2, or what three coarsenings leave room for; None where that is less than 1.2.

    >>> from meshes import MeshSettings
    >>> mesh_ratio(MeshSettings()), mesh_ratio(MeshSettings(element_size=0.2, edge_element_size=0.2))
    (2.0, None)
    """
    room = (_LARGEST / mesh.edge_element_size) ** (1 / 3)
    return None if room < _LEAST_RATIO else min(2.0, room)


def coarser(mesh: MeshSettings, settings: SolverSettings, factor: float) -> tuple[MeshSettings, SolverSettings]:
    """All surface elements `factor` times larger (in the middle to 0.25 a at most); a penalty layer stays the same layer."""
    middle, edges = (min(_LARGEST, factor * size) for size in (mesh.element_size, mesh.edge_element_size))
    if settings.method == "penalty":
        stiffness = (settings.normal_stiffness * factor, settings.tangential_stiffness * factor)
        settings = replace(settings, normal_stiffness=stiffness[0], tangential_stiffness=stiffness[1])
    return replace(mesh, element_size=middle, edge_element_size=edges), settings


def climb(comparison: Comparison, mesh: MeshSettings, settings: SolverSettings, stage: Stage) -> Ladders:
    """Solve every rung of a run that was cut by `mesh` and iterated by `settings`."""
    begun = time.process_time()
    missing: dict[str, str] = {}
    ratio = mesh_ratio(mesh)
    own = Rung("h", 1.0, without_steps(comparison), "", 0.0, len(comparison.result.time), len(comparison.result.x))
    if ratio is None:
        why = "the run's own elements leave no room for three coarser meshes"
        return Ladders((own,), (), (), "none", dict.fromkeys(("mesh", "far field", "penalty"), why), 0.0)
    climber = _Climber(comparison.scene, mesh, settings, ratio, stage, getattr(comparison.result, "scales", None))
    meshes = (own, *(climber.rung(power) for power in (1, 2, 3)))
    far_field = _far_field(climber, meshes[2], missing)
    penalty = _penalty(climber, meshes) if settings.method == "penalty" else ()
    return Ladders(meshes, far_field, penalty, meshes[2].label, missing, time.process_time() - begun)


@dataclass(frozen=True, eq=False)
class _Climber:
    """What all rungs share."""

    scene: Scene
    mesh: MeshSettings
    settings: SolverSettings
    ratio: float
    stage: Stage
    scales: Scales | None

    def name(self, power: int) -> str:
        return f"{self.ratio**power:.3g}h"

    def rung(self, power: int) -> Rung:
        """The rung that is `power` coarsenings above the run."""
        return self.solve(self.name(power), self.ratio**power, *coarser(self.mesh, self.settings, self.ratio**power))

    def solve(self, label: str, size: float, mesh: MeshSettings, settings: SolverSettings) -> Rung:
        import halfplane_fe

        begun = time.process_time()
        with self.stage(f"budget, {label}") as report:
            try:
                result = halfplane_fe.solve(self.scene, mesh, settings, report, scales=self.scales)
            except ConvergenceError as failure:
                return Rung(label, size, {}, f"{label} did not converge: {failure}", time.process_time() - begun)
            values = _values(compare(_on_polygon(self.scene, result), result))
        return Rung(label, size, values, "", time.process_time() - begun, len(result.time), len(result.x))


def _on_polygon(scene: Scene, result: ContactSolution) -> ContactSolution:
    import semi_analytic

    return semi_analytic.solve(scene, x=result.x, time=result.time, straight_steps=True)


def _far_field(climber: _Climber, middle: Rung, missing: dict[str, str]) -> tuple[Rung, ...]:
    bodies, radius = climber.scene.bodies, climber.mesh.far_radius
    if "half_plane" not in (bodies.lower.kind, bodies.upper.kind):
        return ()
    if not 4 <= radius <= 500:
        missing["far field"] = f"a half-disc of radius {radius:g} a leaves no room for one of half and one of twice"
        return ()
    mesh, settings = coarser(climber.mesh, climber.settings, climber.ratio**2)
    large, small = (
        climber.solve(f"{middle.label}, {words}", size, replace(mesh, far_radius=radius / size), settings)
        for words, size in (("2 L", 0.5), ("L/2", 2.0))
    )
    return (large, replace(middle, size=1.0), small)


def _penalty(climber: _Climber, meshes: tuple[Rung, ...]) -> tuple[tuple[Rung, Rung], ...]:
    """With and without the layer on the coarse mesh, and on the one coarser still to show what the mesh does to the difference."""
    exact = replace(climber.settings, method="augmented_lagrangian", normal_stiffness=1e3, tangential_stiffness=1e3)
    found = []
    for power in (2, 3):
        mesh, _ = coarser(climber.mesh, climber.settings, climber.ratio**power)
        label = f"{meshes[power].label}, law met exactly"
        found.append((meshes[power], climber.solve(label, meshes[power].size, mesh, exact)))
    return tuple(found)
