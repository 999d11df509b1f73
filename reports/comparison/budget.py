"""Where an error comes from, metric by metric: mesh, penalty, steps, far field, solver, half-plane
theory's own, idealisation.

They add up to the metric. Every term is measured by itself, everything else fixed, on runs beside
the run: coarser meshes, other far fields, the contact law without a layer. These runs are compared
with half-plane theory on the polygon of their own increments, so that no step error is in them.
What is left over is the idealisation; for half-planes there is none by construction, and what is
left over must be less than its own uncertainty, which tests the whole budget.

At the end the mesh-refinement study of one value: order, kind, value extrapolated to size zero and
its uncertainty. P. J. Roache, J. Fluids Eng. 116 (1994) 405, for solutions that lie on a curve phi
= phi_0 + alpha h^p; L. Eca and M. Hoekstra, J. Comput. Phys. 262 (2014) 104, for four and more
solutions that scatter about one.

# notation: h size of a solution, phi its value, phi_0 the value at size zero, p order
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Literal

import numpy as np

from reports.comparison import Comparison, compare
from reports.comparison.metrics import Metric
from reports.comparison.pairs import are_half_planes
from reports.comparison.work_of_loads import solution_on_straight_steps
from reports.units import PythonNumbers
from scenes import ContactSolution, ConvergenceError, InputError, Scene
from scenes.array_types import Array

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

ROUND_OFF_OF_METRIC = 1e-12  # relative: two values that differ by less are the same
# Keys of the metrics that are parts of the dissipation, that of the load increments and that of all
# else: a budget of them would count it twice.
_PARTS_OF_DISSIPATION = ("dissipation_polygon", "dissipation_step")
# Metric -> name, in `record.errors` of a solution, of the error estimate that theory states for it.
_ERROR_NAME_BY_METRIC = {
    "largest_pressure": "pressure",
    "dissipation_density_peak": "dissipation_density",
    "peak_pressure": "pressure",
    "pressure": "pressure",
    "shear": "shear",
    "dissipation": "dissipation",
    "hysteresis": "dissipation",
    "dissipation_density": "dissipation_density",
    "largest_slip_common": "slip",
}

# Metrics of friction for which theory on grids states no error.
_METRICS_OF_FRICTION_ON_GRIDS = (
    "state",
    "tangential_displacement",
    "displacement_amplitude",
    "bulk_work",
)

# Metrics of the largest pressure, of a revolution and of an instant.
_PEAK_METRICS = ("largest_pressure", "peak_pressure")

# A function that takes the name of a stage and returns a context, which yields
# report(done, total, text).
_Stage = Callable[[str], AbstractContextManager[Callable[[int, int | None, str], None]]]

_STATED_BY_RUN_IN_WORDS = "uncertainty that the run itself states"

_LARGEST_ELEMENT_SIZE = 0.25  # element size that MeshSettings takes, over the contact half-width
_LEAST_SIZE_RATIO = 1.2  # of two meshes that differ enough to show an order
# Radii of a half-disc, over the contact half-width, of which half and twice are radii that
# MeshSettings takes: 2 to 1000.
_RANGE_OF_FAR_RADIUS = (4.0, 500.0)


@dataclass(frozen=True, eq=False)
class Run(PythonNumbers):
    """One run of a refinement study: one size changed, everything else fixed."""

    label: str  # "2h", "L/2": what differs from the run whose errors are measured
    # element size over that of the finest run; of the far field 1/radius over that of that run
    size: float
    # metric -> its value without the error of the load increments; empty where the run failed
    values: Mapping[str, float | None]
    failure: str = ""  # why there are no values
    n_instants: int = 0  # of the load path
    n_contact_nodes: int = 0


@dataclass(frozen=True, eq=False)
class Refinements(PythonNumbers):
    """The runs that measure the errors of one finite-element run, by source of error. "The run"
    below is the run whose errors are measured, h its element size.
    """

    mesh_runs: tuple[Run, ...]  # the run itself and those on coarser meshes
    # with the radii 2 L, L, L/2 on the coarse mesh; empty for bodies with a size of their own, or
    # where it was not measured
    far_field_runs: tuple[Run, ...]
    # (with penalty layer, without) on the mesh of the run and on the next coarser one; empty where
    # the law is met exactly, or where it was not measured
    penalty_pairs: tuple[tuple[Run, Run], ...]
    # label of the mesh on which far field and load increments are measured; "none" without one
    coarse_label: str
    reasons_not_measured: Mapping[str, str]  # source of error -> why it was not measured
    cpu_seconds: float  # CPU time of all but the run itself
    # with the load increments of the run and with halved ones, on the coarse mesh; empty where not
    # measured. None where theory has a solution on the polygon of the increments: none are needed
    step_runs: tuple[Run, ...] | None = None


# Fields of theory on the straight lines between the instants that the page and comparison.json show
# without a budget.
SHOWN_ON_STEPS = ("pressure", "dissipation", "loop_work")


def theory_on_steps(
    result: ContactSolution, fields: Sequence[str] | None = None
) -> ContactSolution | None:
    """Half-plane theory for a result's scene, with loads that run straight from one instant of the
    result to the next, at the result's surface points.

    The result minus this solution holds no error of the load increments. None where bulk stress or
    tilt (an unsymmetric scene) leave theory without a solution on such a path. `fields` names the
    fields that theory computes, such as "pressure": all by default, which an error budget needs.
    """
    import semi_analytic

    scene = result.scene
    field_names = semi_analytic.FIELDS if fields is None else fields
    # A thinned result leaves out instants of a load path that is made of straight lines already:
    # theory follows the path itself.
    joins_instants = not result.thinned
    try:
        return semi_analytic.solve(
            scene,
            x=result.x,
            time=result.time,
            fields=field_names,
            straight_steps=joins_instants,
        )
    except InputError:
        if scene.unsymmetric:
            return None
        raise


def values_without_step_error(comparison: Comparison) -> dict[str, float | None]:
    """Value of each metric, by its key, without the error of the load increments: the result is
    compared with theory on the result's own straight increments (the polygon reference).

    Where bulk stress or tilt leave theory without such a solution, the result is compared with
    theory on the smooth path. InputError where the polygon reference is absent for another reason.
    `comparison.effects` are the compliances of finite bodies, or None.
    """
    if comparison.polygon_reference is not None:
        # without the work that finite elements add for the curve of the path
        result_on_polygon = solution_on_straight_steps(comparison.result)
        return _value_by_metric(
            compare(comparison.polygon_reference, result_on_polygon, effects=comparison.effects)
        )
    if not comparison.is_unsymmetric:
        raise InputError(
            "a budget needs the reference on the polygon of the result's steps: give compare"
            " polygon_reference"
        )
    return _value_by_metric(
        compare(comparison.reference, comparison.result, effects=comparison.effects)
    )


def settings_with_halved_steps(settings: SolverSettings) -> SolverSettings:
    """Solver settings with twice as many load increments in a cycle and a quarter of the tolerance
    on an increment, which is at least 1e-8: the error of the increments falls to a quarter.
    """
    return replace(
        settings,
        steps_per_cycle=2 * settings.steps_per_cycle,
        step_tolerance=max(settings.step_tolerance / 4, 1e-8),
    )


def _value_by_metric(comparison: Comparison) -> dict[str, float | None]:
    """Key of each metric of a comparison -> its value."""
    return {metric.key: metric.value for metric in comparison.metrics}


def mesh_ratio(mesh: MeshSettings) -> float | None:
    """Ratio of the element sizes of neighbouring meshes, for a study with three coarser meshes.

    It is 2, or smaller where the coarsest edge elements would exceed 0.25 a, a the half-width of
    the contact. None where it would be below 1.2. `mesh` is the finest of the four meshes;
    `edge_element_size` is that of its elements at the edges of contact, over a.

    >>> from meshes import MeshSettings
    >>> (
    ...     mesh_ratio(MeshSettings()),
    ...     mesh_ratio(MeshSettings(element_size=0.2, edge_element_size=0.2)),
    ... )
    (2.0, None)
    """
    largest_ratio = (_LARGEST_ELEMENT_SIZE / mesh.edge_element_size) ** (1 / 3)
    if largest_ratio < _LEAST_SIZE_RATIO:
        return None
    return min(2.0, largest_ratio)


def coarser_mesh_and_settings(
    mesh: MeshSettings, settings: SolverSettings, factor: float
) -> tuple[MeshSettings, SolverSettings]:
    """Settings of mesh and solver for a mesh with all surface elements `factor` times larger, but
    at most 0.25 a, a the half-width of the contact.

    Element sizes in `mesh` are over a. The stiffnesses of a penalty layer are stated in E*/h, E*
    the contact modulus, h the element size. They are multiplied by the factor too, so that the
    layer keeps its stiffness wherever no size is limited. `settings` are those of the solver, whose
    `method` may be a penalty layer.
    """
    # elements in the middle of the contact, and at its edges
    middle_size = min(_LARGEST_ELEMENT_SIZE, factor * mesh.element_size)
    edge_size = min(_LARGEST_ELEMENT_SIZE, factor * mesh.edge_element_size)
    if settings.method == "penalty":
        normal_stiffness, tangential_stiffness = settings.stiffnesses
        settings = replace(
            settings,
            normal_stiffness=factor * normal_stiffness,
            tangential_stiffness=factor * tangential_stiffness,
        )
    return replace(mesh, element_size=middle_size, edge_element_size=edge_size), settings


def solve_refinements(
    comparison: Comparison,
    mesh: MeshSettings,
    settings: SolverSettings,
    stage: _Stage,
    coarsenings: int = 3,
) -> Refinements:
    """Solve a scene again by finite elements on coarser meshes, with other far fields, load
    increments or penalty layers. These runs measure the errors of the run with this `mesh` and
    these `settings`. A run that does not converge stands among them with its reason.

    The meshes have edge elements of the sizes h, r h, r^2 h, r^3 h, the first being that of the
    run, r = `mesh_ratio(mesh)`. Where that is None, nothing is solved. Two coarser meshes are the
    least that shows an order of convergence, at a third of the cost. The far field, a half-disc of
    finite radius in place of a half-plane, is measured at r^2 h. So are load increments where
    theory has no solution on their polygon. A penalty layer, springs that let the faces overlap and
    creep, is measured at h and r h.

    Parameters
    ----------
    comparison
        the run compared with half-plane theory
    mesh, settings
        of the run; `mesh.far_radius` is the radius of the half-disc over the half-width a
    stage
        reports progress: a function that takes a label and returns a context for that run
    coarsenings
        number of coarser meshes, 2 or 3

    Returns
    -------
    Refinements
        the runs by source of error, each with the value of every metric; why a source was not
        measured; the CPU time. Penalty pairs: (with layer, without) on the meshes h and r h
    """
    start_seconds = time.process_time()
    ratio = mesh_ratio(mesh)
    base_run = _base_run(comparison)
    if ratio is None:
        return _no_refinements(base_run, comparison)

    # solves the scene on a mesh and compares it with theory; `follows_polygon`: with theory on the
    # polygon of the run's own increments
    solver = _RunSolver(comparison, stage)
    sizes_over_h = [ratio**exponent for exponent in range(1, coarsenings + 1)]
    mesh_runs = (base_run, *_coarser_runs(solver, mesh, settings, sizes_over_h))

    # far field and load increments are measured on the mesh of size r^2 h
    coarse_run = mesh_runs[2]
    coarse_mesh, coarse_settings = coarser_mesh_and_settings(mesh, settings, ratio**2)
    far_field_runs: tuple[Run, ...] = ()
    reason_without_far_field = _reason_without_far_field(comparison.scene, mesh)
    if _has_far_field(comparison.scene) and not reason_without_far_field:
        far_field_runs = _far_field_runs(solver, coarse_run, coarse_mesh, coarse_settings)
    # Where theory has no solution on the increments of a run, their error is measured by halving
    # them; `step_runs`: the run with its own increments, and that with halved ones.
    step_runs: tuple[Run, ...] | None = None
    if not solver.follows_polygon:
        step_runs = (coarse_run, _finer_steps_run(solver, coarse_run, coarse_mesh, coarse_settings))
    penalty_pairs: tuple[tuple[Run, Run], ...] = ()
    if settings.method == "penalty":
        penalty_pairs = _penalty_runs(solver, mesh_runs[:2], mesh, settings)
    return Refinements(
        mesh_runs=mesh_runs,
        far_field_runs=far_field_runs,
        penalty_pairs=penalty_pairs,
        coarse_label=coarse_run.label,
        reasons_not_measured=(
            {"far field": reason_without_far_field} if reason_without_far_field else {}
        ),
        cpu_seconds=time.process_time() - start_seconds,
        step_runs=step_runs,
    )


def _base_run(comparison: Comparison) -> Run:
    """The run whose errors are measured, as the first of a refinement study: size h, and the value
    of each metric without the error of its load increments.
    """
    return Run(
        label="h",
        size=1.0,
        values=values_without_step_error(comparison),
        failure="",
        n_instants=len(comparison.result.time),
        n_contact_nodes=len(comparison.result.x),
    )


def _coarser_runs(
    solver: _RunSolver, mesh: MeshSettings, settings: SolverSettings, sizes: Iterable[float]
) -> Iterator[Run]:
    """The runs on coarser meshes, in the order of `sizes`: element sizes over that of the `mesh` of
    the run whose errors are measured. `settings` are the solver's for that run.
    """
    for size in sizes:
        mesh_of_run, settings_of_run = coarser_mesh_and_settings(mesh, settings, size)
        yield solver.solved_run(f"{size:.3g}h", size, mesh_of_run, settings_of_run)


def _has_far_field(scene: Scene) -> bool:
    """Whether a body of the scene is a half-plane, which the mesh cuts off at a half-disc."""
    return "half_plane" in (scene.bodies.lower.kind, scene.bodies.upper.kind)


def _reason_without_far_field(scene: Scene, mesh: MeshSettings) -> str:
    """Why the error of the far field is not measured: half and twice of the radius of the half-disc
    cannot both be meshed, since it is not between 4 and 500 half-widths a. "" where they can, and
    for bodies with a size of their own, which have no far field.
    """
    can_be_meshed = _RANGE_OF_FAR_RADIUS[0] <= mesh.far_radius <= _RANGE_OF_FAR_RADIUS[1]
    if can_be_meshed or not _has_far_field(scene):
        return ""
    return (
        f"a half-disc of radius {mesh.far_radius:g} a leaves no room for one of half and"
        " one of twice"
    )


def _no_refinements(base_run: Run, comparison: Comparison) -> Refinements:
    """A refinement study that holds one run only, the one whose errors would be measured
    (`base_run`): its elements are so large that three coarser meshes are not possible. It states
    this reason for the mesh, the far field and the penalty layer.
    """
    reason = "the run's own elements leave no room for three coarser meshes"
    # Runs with halved load increments: None where theory on straight increments makes them
    # needless; empty where they are needed, and there are none.
    step_runs = () if comparison.polygon_reference is None else None
    return Refinements(
        mesh_runs=(base_run,),
        far_field_runs=(),
        penalty_pairs=(),
        coarse_label="none",
        reasons_not_measured=dict.fromkeys(("mesh", "far field", "penalty"), reason),
        cpu_seconds=0.0,
        step_runs=step_runs,
    )


class _RunSolver:
    """Solves the runs of a refinement study, each compared with half-plane theory.

    Attributes
    ----------
    scene
        of all runs
    effects
        compliances that finite bodies add to half-planes; None where they are not needed
    scales
        what a coarse run of finite elements found and the meshes are made by, such as the largest
        half-width of contact; None for an external result
    follows_polygon
        whether theory follows the polygon of each run's own load increments; else the smooth path
    stage
        takes the label of a run and returns a context that reports its progress
    """

    def __init__(self, comparison: Comparison, stage: _Stage) -> None:
        """Take what all runs share from the comparison of the run whose errors are measured."""
        self.scene = comparison.scene
        self.effects = comparison.effects
        self.scales = getattr(comparison.result, "scales", None)
        self.follows_polygon = comparison.polygon_reference is not None
        self.stage = stage

    def solved_run(
        self, label: str, size: float, mesh: MeshSettings, settings: SolverSettings
    ) -> Run:
        """Solve the scene by finite elements and compare the solution with half-plane theory. The
        returned run holds the value of each metric. Where the finite elements do not converge, or
        theory has no solution, it holds the reason and no values.

        The solver's attributes are those of all runs: `scene`, `effects` (compliances of finite
        bodies, or None), `scales` (half-width of contact, ...: meshes need it), `stage` (progress),
        and `follows_polygon`: whether theory takes the straight load increments of the run.

        Parameters
        ----------
        label
            name of the run, such as "2h"
        size
            the size that is refined, element size or 1/radius of a half-disc, over its value in the
            run whose errors are measured
        mesh, settings
            of this run
        """
        import halfplane_fe

        # `report`: the function to which the solver reports its progress
        with self.stage(f"budget, {label}") as report:
            try:
                solution = halfplane_fe.solve(
                    self.scene, mesh, settings, report, scales=self.scales
                )
            except ConvergenceError as failure:
                return Run(label, size, {}, f"{label} did not converge: {failure}")
            reference = self._half_plane_theory(solution)
        if reference is None:
            return Run(label, size, {}, f"{label}: half-plane theory has no answer on its steps")
        # both follow the same loads: the polygon of the increments, or the smooth path
        compared_solution = (
            solution_on_straight_steps(solution) if self.follows_polygon else solution
        )
        values = _value_by_metric(compare(reference, compared_solution, effects=self.effects))
        return Run(
            label=label,
            size=size,
            values=values,
            failure="",
            n_instants=len(solution.time),
            n_contact_nodes=len(solution.x),
        )

    def _half_plane_theory(self, solution: ContactSolution) -> ContactSolution | None:
        """Half-plane theory at the points and instants of a run; None where it has no solution."""
        import semi_analytic

        if self.follows_polygon:
            return theory_on_steps(solution)
        return semi_analytic.solve(self.scene, x=solution.x, time=solution.time)


def _finer_steps_run(
    solver: _RunSolver, coarse_run: Run, mesh: MeshSettings, settings: SolverSettings
) -> Run:
    """The run on the coarse `mesh` with load increments of half the length of `settings`."""
    label = f"{coarse_run.label}, halved increments"
    return solver.solved_run(label, coarse_run.size, mesh, settings_with_halved_steps(settings))


def _far_field_runs(
    solver: _RunSolver, coarse_run: Run, mesh: MeshSettings, settings: SolverSettings
) -> tuple[Run, ...]:
    """Three runs that show what the finite radius L of a meshed half-disc, in place of a
    half-plane, does to a result: with the radius 2 L, L and L/2.

    `coarse_run` is the run with the radius L, solved already with this `mesh` and these `settings`.
    The size of a run is its 1/radius over 1/L: 0.5, 1 and 2. `solver.solved_run` solves the scene
    by finite elements and compares the solution with theory.
    """
    runs = []
    # `far_radius`: L over the half-width of the contact
    for radius_in_words, size in (("2 L", 0.5), ("L/2", 2.0)):
        mesh_of_run = replace(mesh, far_radius=mesh.far_radius / size)
        label = f"{coarse_run.label}, {radius_in_words}"
        runs.append(solver.solved_run(label, size, mesh_of_run, settings))
    run_with_large_disc, run_with_small_disc = runs
    return (run_with_large_disc, replace(coarse_run, size=1.0), run_with_small_disc)


def _penalty_runs(
    solver: _RunSolver, runs: Iterable[Run], mesh: MeshSettings, settings: SolverSettings
) -> tuple[tuple[Run, Run], ...]:
    """Pairs of runs that show the error of a penalty layer: each of `runs`, and a run on the same
    mesh in which Coulomb's law is met exactly.

    `runs` are those on the finest mesh and the next coarser one. The second pair shows how the mesh
    changes the difference. Still coarser meshes would not show it: on them the place of an edge
    within its element changes W more than the layer does.

    Parameters
    ----------
    solver
        solves the scene on a mesh and gives the run
    runs
        `size`: element size over that of the finest mesh
    mesh, settings
        of the run on the finest mesh
    """
    # contact and Coulomb's law exactly, by search for the nodes in contact and in stick
    exact_settings = replace(
        settings, method="active_set", normal_stiffness=None, tangential_stiffness=None
    )
    pairs = []
    for run in runs:
        mesh_of_run, _ = coarser_mesh_and_settings(mesh, settings, run.size)
        label = f"{run.label}, law met exactly"
        pairs.append((run, solver.solved_run(label, run.size, mesh_of_run, exact_settings)))
    return tuple(pairs)


@dataclass(frozen=True)
class Term(PythonNumbers):
    """One source of error in one metric, in the unit of the metric."""

    name: str  # the source: "mesh", "step", ...
    # the error, with its sign; None where only scatter was seen, or nothing was measured
    value: float | None
    uncertainty: float | None  # of the error; None where nothing was measured
    how_measured: str  # by what method, or why not
    # whether the uncertainty is never exceeded: such bounds add up, the others add by squares
    is_bound: bool = False
    # order, kind: observed order of convergence and kind of sequence of the runs, if any
    order: float | None = None
    kind: str = ""

    @property
    def is_measured(self) -> bool:
        """Whether the source has a stated uncertainty."""
        return self.uncertainty is not None


@dataclass(frozen=True)
class Budget:
    """The error of one metric and where it comes from."""

    metric: Metric  # its value is the whole error E
    terms: tuple[Term, ...]  # every source but the idealisation
    # whether the bodies are the half-planes of theory, so that there is no idealisation error
    are_half_planes: bool

    @property
    def error(self) -> float:
        """E, the value of the metric; NaN where it has none."""
        return float("nan") if self.metric.value is None else self.metric.value

    @property
    def rest_of_error(self) -> float:
        """E minus all measured errors, a term without a value counting as 0: the idealisation error
        of real bodies; of half-planes, the part of E that is unexplained. NaN where E is.
        """
        return self.error - sum(term.value or 0.0 for term in self.terms)

    @property
    def uncertainty(self) -> float | None:
        """u, the uncertainty of the rest: root of the sum of squares of those of the terms, plus
        the sum of those that are bounds. None where a term was not measured.
        """
        if not all(term.is_measured for term in self.terms):
            return None
        bounds = [term.uncertainty or 0.0 for term in self.terms if term.is_bound]
        estimates = [term.uncertainty or 0.0 for term in self.terms if not term.is_bound]
        return math.hypot(*estimates) + sum(bounds)

    @property
    def metric_with_uncertainty(self) -> Metric:
        """The metric with u for its uncertainty; as it is where u is not known."""
        if self.uncertainty is None:
            return self.metric
        return replace(self.metric, uncertainty=self.uncertainty)

    @property
    def is_resolved(self) -> bool | None:
        """Whether the rest exceeds its uncertainty, |rest| > u; None where that is not known."""
        if self.uncertainty is None or not math.isfinite(self.rest_of_error):
            return None
        return abs(self.rest_of_error) > self.uncertainty

    @property
    def is_covered(self) -> bool | None:
        """Whether the stated uncertainty covers the rest: known for half-planes only, where the
        true rest is zero. None otherwise.
        """
        if not self.are_half_planes or self.is_resolved is None:
            return None
        return not self.is_resolved


@dataclass(frozen=True, eq=False)
class ErrorBudget:
    """Budgets of all metrics, the runs that measured them, and the CPU time of the run itself."""

    budgets: tuple[Budget, ...]
    refinements: Refinements
    seconds_of_run: float

    @property
    def cpu_time_ratio(self) -> float:
        """CPU time of the run with its budget over that of the plain run."""
        return 1 + self.refinements.cpu_seconds / self.seconds_of_run

    def budget(self, key: str) -> Budget:
        """The budget of a metric; KeyError where it has none."""
        return {budget.metric.key: budget for budget in self.budgets}[key]

    @property
    def coverage_in_words(self) -> str:
        """A sentence: for how many metrics the stated uncertainty covers the part of the error that
        no measured term explains. It can be checked for half-planes only.

        `budgets` holds a budget for each metric. Its `is_covered` is None where that is not known.
        """
        known_budgets = [budget for budget in self.budgets if budget.is_covered is not None]
        if not known_budgets:
            return (
                "cannot be checked here: the exact answer of these bodies is unknown (that of"
                " half-planes is known)"
            )
        n_covered = sum(bool(budget.is_covered) for budget in known_budgets)
        return (
            f"{n_covered} of {len(known_budgets)} metrics: the stated uncertainty"
            " covers what the measured terms leave unexplained"
        )


def error_budget(
    comparison: Comparison, refinements: Refinements, seconds_of_run: float
) -> ErrorBudget:
    """For every metric of `comparison` with a finite value, the part of each source of error in it:
    mesh, penalty layer, load increments, far field, iteration, theory.

    `refinements` holds the runs on coarser meshes, with other far fields, ... that measure them.
    `seconds_of_run` is the CPU time of the run without the refinements. The two metrics that are
    parts of the dissipation, that of the load increments and the rest, have no budget of their own.
    """
    # theory is the exact solution for half-planes
    has_exact_solution = are_half_planes(comparison.scene)
    # an error that is the same in all metrics; the other five differ from metric to metric
    iteration_term = _iteration_term(comparison)
    budgets = []
    for metric in comparison.metrics:
        has_value = metric.value is not None and math.isfinite(metric.value)
        # _PARTS_OF_DISSIPATION: keys of the two metrics that are parts of the dissipation
        if not has_value or metric.key in _PARTS_OF_DISSIPATION:
            continue
        terms = (
            _mesh_term(metric, comparison, refinements),
            _penalty_term(metric, comparison, refinements),
            _step_term(metric, refinements),
            _far_field_term(metric, comparison, refinements),
            iteration_term,
            _theory_term(metric, comparison),
        )
        budgets.append(Budget(metric, terms, has_exact_solution))
    return ErrorBudget(tuple(budgets), refinements, seconds_of_run)


def _sizes_and_values(metric: Metric, runs: Iterable[Run]) -> list[tuple[float, float]]:
    """(size, value of the metric) of every run in which the metric has a finite value. The sizes
    are ratios of element sizes, or of 1/radius of a half-plane: see `Run`.
    """
    pairs = []
    for run in runs:
        value = run.values.get(metric.key)
        if value is not None and math.isfinite(value):
            pairs.append((run.size, value))
    return pairs


def _finite_values(metric: Metric, runs: Iterable[Run]) -> list[float]:
    """Value of the metric in every run in which it is finite."""
    return [value for _, value in _sizes_and_values(metric, runs)]


def _unmeasured_term(
    name: str, runs: Iterable[Run] = (), reason: str = "", first_reason: str = ""
) -> Term:
    """A term without value and uncertainty, in words why: `first_reason`, then `reason`. Where that
    is "", the failures of `runs`, else that a run has no finite value.
    """
    failures = "; ".join(run.failure for run in runs if run.failure)
    last_reason = reason or failures or "a run has no finite value"
    return Term(name, None, None, f"not measured: {first_reason}{last_reason}")


def _extrapolated_term(
    name: str, metric: Metric, refinements: Refinements, runs: tuple[Run, ...], formal_order: float
) -> Term:
    """The error of a metric by one source: its value in the run itself (size 1) minus the value at
    size zero, extrapolated from `runs`.

    The term has no value where the values of the runs oscillate or diverge. It is not measured
    where fewer than three runs have a finite value, or the run itself has none.

    Parameters
    ----------
    name
        source of error: "mesh" or "far field"
    refinements
        states, by source of error, why it was not measured
    runs
        runs that differ in one size only, the finest first. A size is relative to the run itself:
        element size, or 1/radius of the half-disc that stands for a half-plane
    formal_order
        order of convergence that the method has in theory
    """
    value_at_size = dict(_sizes_and_values(metric, runs))
    reason = refinements.reasons_not_measured.get(name, "")
    if reason or len(value_at_size) < 3 or 1.0 not in value_at_size:
        return _unmeasured_term(name, runs, reason)

    # values that differ by 1e-12 or less are equal
    refinement = Refinement(
        sizes=tuple(value_at_size),
        values=tuple(value_at_size.values()),
        formal_order=formal_order,
        rounding=ROUND_OFF_OF_METRIC,
    )
    # value at size zero, its uncertainty, how the values change with the size, and by what rule
    extrapolation = extrapolate(refinement)
    error_of_run = None
    if extrapolation.kind not in ("oscillating", "diverging"):
        error_of_run = value_at_size[1.0] - (extrapolation.value or 0.0)
    return Term(
        name,
        error_of_run,
        extrapolation.uncertainty,
        extrapolation.rule,
        order=extrapolation.order,
        kind=extrapolation.kind,
    )


def _mesh_term(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """The error that the mesh makes in a metric: value of the run minus that at size zero.

    That comes from the coarser meshes; the term is not measured where they give none. Where
    the run states an uncertainty of its amount, such as its W, three cases are distinguished:

    - the error by the coarser meshes is larger than that: both error and uncertainty are theirs;
    - their uncertainty is larger than that of the run: no error, and the uncertainty of the run;
    - else: their error (none where they only scatter), and the uncertainty of the run.

    Where it states none, or uses a penalty layer: their error and uncertainty. That uncertainty is
    at least the one stated of the metric's value, of its contact or stick edge, or of its pressure
    peak.

    The returned term holds error, uncertainty, and in words how both were measured.
    """
    formal_order = 2.0
    # by the coarser meshes alone; its `kind`: monotone, oscillating, ...
    term = _extrapolated_term("mesh", metric, refinements, refinements.mesh_runs, formal_order)
    if term.uncertainty is None:
        return term
    labels = ", ".join(run.label for run in refinements.mesh_runs if not run.failure)
    words_on_meshes = f"{labels}: {term.kind}; {term.how_measured}"
    # in the unit of the metric; None where the run states none
    stated_uncertainty = _uncertainty_of_value(metric, comparison)
    if stated_uncertainty is None:
        return _with_stated_uncertainties(
            replace(term, how_measured=words_on_meshes), metric, comparison
        )
    if term.value is not None and abs(term.value) > stated_uncertainty:
        return replace(
            term,
            how_measured=f"{words_on_meshes}; the run itself states less, {stated_uncertainty:.1e}",
        )
    if stated_uncertainty < term.uncertainty:
        # The places of the edges within their elements move a value from mesh to mesh: a few meshes
        # show that scatter, and no order.
        words_on_meshes = (
            f"{words_on_meshes}, {term.uncertainty:.1e}; instead the smaller uncertainty that the"
            " run itself states"
        )
        return Term("mesh", None, stated_uncertainty, words_on_meshes)
    return replace(
        term,
        uncertainty=stated_uncertainty,
        how_measured=f"{words_on_meshes}; {_STATED_BY_RUN_IN_WORDS}",
    )


def _with_stated_uncertainties(term: Term, metric: Metric, comparison: Comparison) -> Term:
    """The `term` of the mesh in a metric, with at least the uncertainty that the run itself states.
    That is the largest of those of the metric, of its contact or stick edge, and of its pressure
    peak. An infinite one raises nothing. All are in the unit of the metric.
    """
    stated_uncertainties = (
        metric.uncertainty or 0.0,
        uncertainty_of_edge(metric, comparison),
        _uncertainty_of_peak(metric, comparison),
    )
    # one that is not known, NaN, hides none of the others
    least_uncertainty = float(np.fmax.reduce(stated_uncertainties))
    if (term.uncertainty or 0.0) < least_uncertainty < math.inf:
        return replace(
            term,
            uncertainty=least_uncertainty,
            how_measured=f"{term.how_measured}; {_STATED_BY_RUN_IN_WORDS}",
        )
    return term


def _uncertainty_of_value(metric: Metric, comparison: Comparison) -> float | None:
    """Uncertainty that the result states of a metric's value, in the unit of the metric; None where
    it states none. None with a penalty layer too, whose error is a part of what it states.
    """
    if comparison.result.settings.get("solver", {}).get("method") == "penalty":
        return None
    return metric.stated_by_result


def uncertainty_of_edge(metric: Metric, comparison: Comparison) -> float:
    """Uncertainty that a result itself states of a contact or stick edge at the instant of the
    metric, the larger of left and right, over the reference half-width. 0 for metrics of no edge,
    and where none is stated. Where one edge has no estimate, NaN, that of the other one counts; NaN
    where neither has one.

    `metric.key` is "contact_edge" or "stick_edge" for an edge; `metric.time` is its worst instant.
    """
    result = comparison.result
    # (n_instants, 2), left and right edge [length], as `contact_edge_uncertainty`
    edge_uncertainties = getattr(result, f"{metric.key}_uncertainty", None)
    # pressure peaks have an attribute of such a name too, and are no edges
    # _PEAK_METRICS: keys of the metrics of the largest pressure
    if metric.key in _PEAK_METRICS or edge_uncertainties is None or metric.time is None:
        return 0.0
    instant_index = int(abs(result.time - metric.time).argmin())
    return float(np.fmax.reduce(edge_uncertainties[instant_index])) / comparison.scales.half_width


def _uncertainty_of_peak(metric: Metric, comparison: Comparison) -> float:
    """Uncertainty that the result states of its largest pressure, over the largest pressure of the
    reference. 0 for metrics that are no pressure peak, for half-planes, and where none is stated.

    It is needed because coarser meshes may agree by chance: the peak is a smooth function of the
    element size only where the contact edges lie alike in their elements. For half-planes it is not
    needed: their true error is known, and the coarser meshes cover it.
    """
    # pressure peaks: largest pressure of the cycle, and of each instant
    if metric.key not in _PEAK_METRICS or are_half_planes(comparison.scene):
        return 0.0
    uncertainty = comparison.result.uncertainties.get("largest_pressure", math.nan)  # [stress]
    if not math.isfinite(uncertainty):
        return 0.0
    uncertainty_over_result_peak = float(uncertainty / comparison.result.pressure.max())
    # the metric is result/reference - 1
    peak_ratio = abs(1 + (metric.value or 0.0))
    return uncertainty_over_result_peak * peak_ratio


def _step_term(metric: Metric, refinements: Refinements) -> Term:
    """The error that straight load increments make in a metric, where the loads follow a curve.

    It is known exactly where theory can follow the polygon of the increments: value by theory on
    the smooth path minus value by theory on the polygon. Elsewhere the error is 4/3 of the change
    by halved increments, as for an error of second order. Its uncertainty is that change. Round-off
    (1e-12) is added, and alone where the error is known exactly.

    Of `refinements`: `step_runs` has the increments of the run, then halved ones, on the mesh
    `coarse_label`; None where theory follows the polygon. `mesh_runs` starts with the run itself,
    whose `values` are compared with theory on the polygon. `metric.value`: on the smooth path.
    """
    if refinements.step_runs is not None:
        values = _finite_values(metric, refinements.step_runs)
        if len(values) < 2:
            first_reason = "half-plane theory has no answer on the polygon of the steps, and "
            return _unmeasured_term("step", refinements.step_runs, first_reason=first_reason)
        value_with_increments, value_with_halved_increments = values
        change = value_with_increments - value_with_halved_increments
        how_measured = (
            f"halved increments at {refinements.coarse_label}, second order; half-plane theory has"
            " no answer on the polygon of the steps"
        )
        return Term("step", 4 / 3 * change, abs(change) + ROUND_OFF_OF_METRIC, how_measured)
    # the first run is the result itself, compared with theory on the polygon
    value_on_polygon = refinements.mesh_runs[0].values.get(metric.key)
    if value_on_polygon is None or not math.isfinite(value_on_polygon) or metric.value is None:
        reason = "theory on the polygon of the steps has no such value"
        return _unmeasured_term("step", reason=reason)
    how_measured = (
        "exact: half-plane theory on the smooth path against itself on the polygon of the steps"
    )
    return Term(
        "step", metric.value - value_on_polygon, ROUND_OFF_OF_METRIC, how_measured, is_bound=True
    )


def _penalty_term(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """The error that a penalty layer makes in a metric: value with the layer minus value without
    it.

    Its uncertainty is twice the change of that difference on the next coarser mesh. Where the
    solver uses no layer there is no error, and the uncertainty 0 is a bound (never exceeded). The
    term is not measured where one of the four runs has no finite value.

    `refinements.penalty_pairs`: runs (with layer, without) on the mesh of the run, then on the next
    coarser one.
    """
    if comparison.result.settings.get("solver", {}).get("method") != "penalty":
        how_measured = "none by construction: the law is met exactly"
        return Term("penalty", None, 0.0, how_measured, is_bound=True)
    differences = []
    for run_pair in refinements.penalty_pairs:
        values = _finite_values(metric, run_pair)
        if len(values) == 2:
            value_with_layer, value_without_layer = values
            differences.append(value_with_layer - value_without_layer)
    reason = refinements.reasons_not_measured.get("penalty", "")
    if reason or len(differences) < 2:
        return _unmeasured_term("penalty", chain(*refinements.penalty_pairs), reason)
    how_measured = (
        "with the layer less without it, at h; twice what that changes by at the next coarser mesh"
    )
    difference_on_mesh, difference_on_coarser_mesh = differences
    uncertainty = 2 * abs(difference_on_mesh - difference_on_coarser_mesh)
    return Term("penalty", difference_on_mesh, uncertainty, how_measured)


def _far_field_term(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """The error that the finite radius L of a meshed half-plane makes in a metric phi:
    phi(L) − phi(infinity) on the coarse mesh.

    There is an error where the values for the three radii are equal, or are of a plausible order (1
    to 4.2) and the error is at least the uncertainty that a run on the coarse mesh would state.
    Else the term has no value, and its uncertainty is the spread of the three values. No error and
    the uncertainty 0 for bodies with a size of their own.

    `refinements` holds the runs with the radii 2 L, L and L/2, and the runs on meshes of different
    element size; the coarse mesh is that with the label `coarse_label`. The uncertainty that a run
    states of its value is taken to grow with the element size; `metric.stated_by_result` is that of
    the run itself.
    """
    if not _has_far_field(comparison.scene):
        return Term(
            "far field", None, 0.0, "none: the bodies have a size of their own", is_bound=True
        )
    formal_order = 4.0  # tractions under given loads converge with the fourth power of 1/L
    runs = refinements.far_field_runs
    # error and uncertainty by extrapolation to 1/L = 0; `term.kind`: how the values change with it
    term = _extrapolated_term("far field", metric, refinements, runs, formal_order)
    if term.uncertainty is None:
        return term
    how_measured = f"radius 2 L, L, L/2 on the mesh of {refinements.coarse_label}: {term.kind}"
    # the element size of the coarse mesh, over that of the run
    size_by_label = {run.label: run.size for run in refinements.mesh_runs}
    coarse_size = size_by_label[refinements.coarse_label]
    stated_on_coarse_mesh = (metric.stated_by_result or 0.0) * coarse_size
    is_resolved = not abs(term.value or 0.0) < stated_on_coarse_mesh
    is_plausible = _is_plausible(term.order, formal_order) and is_resolved
    if term.kind == "exact" or is_plausible:
        return replace(term, how_measured=how_measured)
    values = _finite_values(metric, runs)
    spread = max(values) - min(values)
    how_measured += "; not resolved: the scatter between meshes is as large"
    return replace(term, value=None, uncertainty=spread, how_measured=how_measured)


def _iteration_term(comparison: Comparison) -> Term:
    """The error by rounding and by the end of the iteration, the same for every metric: no value,
    and for uncertainty the worst residual of any load step, dimensionless, as a bound that is never
    exceeded. Not measured where the result states no residuals.
    """
    # of the laws of contact, those by residuals that the solver recorded; `value`: the largest
    certificates_of_record = [
        check for check in comparison.result_certificates if check.source == "record"
    ]
    if not certificates_of_record:
        return _unmeasured_term("solver", reason="the result states no residuals")
    worst_certificate = max(certificates_of_record, key=lambda check: check.value)
    how_measured = f"worst residual of any step: {worst_certificate.name}"
    return Term("solver", None, worst_certificate.value, how_measured, is_bound=True)


def _theory_term(metric: Metric, comparison: Comparison) -> Term:
    """The error of half-plane theory's own quadratures, series and grids in a metric: no value,
    since the sign is not known. The uncertainty, a bound that is never exceeded, is the largest
    estimate by theory itself, on the smooth path and on the polygon of the load increments;
    round-off (1e-12) where it states none, as of closed forms.
    """
    # name of this quantity among the relative errors that theory states; "... at the edge" is one
    # of points that lie there
    name_of_error = _ERROR_NAME_BY_METRIC.get(metric.key, metric.key)
    theory_solutions = [comparison.reference]
    if comparison.polygon_reference is not None:
        theory_solutions.append(comparison.polygon_reference)
    error_estimates = [
        error
        for solution in theory_solutions
        for name, error in solution.record.errors.items()
        if name == name_of_error or name.startswith(f"{name_of_error} ")
    ]
    if metric.stated_by_reference:
        error_estimates.append(metric.stated_by_reference)
    if metric.key == "stick_edge":
        # on grids: the width of a cell [length]
        error_estimates += [
            solution.uncertainties["stick_edges"] / comparison.scales.half_width
            for solution in theory_solutions
            if "stick_edges" in solution.uncertainties
        ]
    # work.counts: what theory counted of its work, "grids" where it used grids of points
    is_on_grids = any("grids" in solution.work.counts for solution in theory_solutions)
    if error_estimates:
        uncertainty = max(error_estimates) + ROUND_OFF_OF_METRIC
        how_measured = "its own estimate of quadratures and series"
        if is_on_grids:
            how_measured = "its own estimate of grids, quadratures and series"
    else:
        uncertainty = ROUND_OFF_OF_METRIC
        how_measured = "closed forms: rounding"
        if is_on_grids and metric.key in _METRICS_OF_FRICTION_ON_GRIDS:
            how_measured = "rounding alone: theory on grids states no error of this value"
    return Term("half-plane theory", None, uncertainty, how_measured, is_bound=True)


# --------------------------------------------------------------- mesh-refinement study of one value
_Kind = Literal["monotone", "oscillating", "diverging", "exact", "too few"]

# Safety factors on an uncertainty: for a plausible order, and for any other order (Eca and Hoekstra
# 2014).
_SAFETY_FACTOR = 1.25
_LARGE_SAFETY_FACTOR = 3.0
# Smallest and largest order p that is searched. Beyond 16 a size ratio of 2 leaves no digits
# between the two finest solutions.
_RANGE_OF_SEARCHED_ORDERS = (0.01, 16.0)


@dataclass(frozen=True)
class Refinement(PythonNumbers):
    """Values of one quantity from solutions of different size, everything else fixed."""

    sizes: tuple[float, ...]  # h > 0 of each solution, finest first, strictly growing
    values: tuple[float, ...]  # phi of each solution, finite
    # order of the method in theory; an observed order is plausible from 0.25 to 1.05 times that
    formal_order: float = 2.0
    rounding: float = 0.0  # values that differ by no more than this are equal

    def __post_init__(self) -> None:
        """Check the element sizes of the solutions of a refinement study, and the values of one
        quantity in them. ValueError where the sizes are not positive and strictly growing, where a
        value is not finite, or where the numbers of sizes and values differ.
        """
        super().__post_init__()  # NumPy numbers become Python numbers
        if len(self.sizes) != len(self.values) or not self.sizes:
            raise ValueError(f"{len(self.sizes)} sizes for {len(self.values)} values")
        if min(self.sizes) <= 0 or any(np.diff(self.sizes) <= 0):
            raise ValueError(
                f"sizes {self.sizes} are not positive and growing: the finest comes first"
            )
        if not all(map(math.isfinite, self.values)):
            raise ValueError(f"values {self.values} are not finite")

    @property
    def spread(self) -> float:
        """Largest minus smallest value."""
        return max(self.values) - min(self.values)

    def is_plausible(self, order: float | None) -> bool:
        """Whether theory admits an observed order; no order is not admitted."""
        return _is_plausible(order, self.formal_order)


def _is_plausible(order: float | None, formal: float) -> bool:
    """Whether theory admits an observed order, for the formal order 2 those from 0.5 to 2.1 (Eca
    and Hoekstra 2014).
    """
    return order is not None and formal / 4 <= order <= 1.05 * formal


@dataclass(frozen=True)
class Extrapolation(PythonNumbers):
    """The result of a refinement study: the value at size zero with its uncertainty."""

    order: float | None  # observed p; None where there is none
    kind: _Kind  # how the values change as h falls
    value: float | None  # phi_0; None for a single solution
    # |phi_0 - truth| and |finest phi - truth| should both be less, about 19 times of 20; None for a
    # single solution
    uncertainty: float | None
    rule: str  # the rule that gave value and uncertainty, in words


def observed_order(sizes: tuple[float, ...], values: tuple[float, ...]) -> float | None:
    """Order of convergence p of three solutions: that of the curve phi_0 + alpha h^p through their
    values, phi_0 the value at size zero, alpha a factor. None where the values are not monotone, or
    where p lies outside 0.01 to 16.

    Parameters
    ----------
    sizes
        (3,) element sizes h, the finest first
    values
        (3,) values phi of one quantity

    Examples
    --------
    >>> round(observed_order((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178)), 6)
    1.78617
    """
    # notation: phi_3 - phi_2 over phi_2 - phi_1 is (h_3^p - h_2^p)/(h_2^p - h_1^p), which grows
    # with p: (h_2/h_1)^p times (r_c^p - 1)/(r_f^p - 1), r_c = h_3/h_2, r_f = h_2/h_1
    fine_change = values[1] - values[0]
    coarse_change = values[2] - values[1]
    if fine_change == 0 or coarse_change / fine_change <= 0:
        return None
    log_of_changes = math.log(coarse_change / fine_change)
    fine_log_ratio = math.log(sizes[1] / sizes[0])
    coarse_log_ratio = math.log(sizes[2] / sizes[1])

    def misfit(p: float) -> float:
        """log of the ratio of changes that the order p gives, minus log of the actual ratio."""
        growth = math.expm1(p * coarse_log_ratio) / math.expm1(p * fine_log_ratio)
        return p * fine_log_ratio + math.log(growth) - log_of_changes

    least_order, largest_order = _RANGE_OF_SEARCHED_ORDERS
    if misfit(least_order) >= 0 or misfit(largest_order) <= 0:
        return None
    from scipy.optimize import brentq  # a tenth of a second, for few comparisons

    return float(brentq(misfit, least_order, largest_order, xtol=1e-14))


def kind_of_sequence(refinement: Refinement) -> _Kind:
    """How the values phi of a refinement study change as the element size h falls, in a word.

    "too few": fewer than three values. "exact": all values are equal to rounding. Changes of one
    sign: "monotone" where the curve phi_0 + alpha h^p that fits best (phi_0 the value at size zero,
    alpha a factor, p the order) has a p from 0.01 to 16, else "diverging". Other changes (both
    signs, or some 0): "oscillating" where the change between the two finest meshes is smaller than
    the largest of the others, else "diverging".

    `refinement` holds the values phi of one quantity (finest mesh first), their spread (largest
    minus smallest) and the difference that counts as rounding.
    """
    if len(refinement.values) < 3:
        return "too few"
    if refinement.spread <= refinement.rounding:
        return "exact"
    changes = np.diff(refinement.values)
    if np.all(changes > 0) or np.all(changes < 0):
        return "diverging" if _order_of_best_curve(refinement) is None else "monotone"
    finest_change = abs(changes[0])
    largest_other_change = np.abs(changes[1:]).max()
    return "oscillating" if finest_change < largest_other_change else "diverging"


def extrapolate(refinement: Refinement) -> Extrapolation:
    """Extrapolate a value to element size zero from solutions on meshes of different size.
    Returns the order of convergence, the kind of sequence (monotone, oscillating, ...), the value
    at size zero and its uncertainty.

    - One mesh: neither value nor uncertainty. Two: the order of the method in theory (formal
      order), three times the correction.
    - All values equal to rounding: the value of the finest mesh, and that rounding.
    - Every three neighbouring meshes have plausible orders (a quarter of the formal order to 1.05
      of it) that agree to a quarter of the formal order: Roache's index with the safety factor
      1.25, the uncertainty by the lowest order.
    - Otherwise monotone, four meshes or more: least squares. The uncertainty is at least the spread
      of the three finest.
    - Oscillating or diverging, four meshes or more: the finest value. The uncertainty is at least
      the spread of all.
    - Three meshes otherwise: the finest value, with three times the spread.

    `refinement` holds sizes and values, the finest mesh first; spread: largest minus smallest
    value.

    The two lower bounds on the uncertainty are ours. Where noise is about as large as the trend,
    the published rules on four solutions cover the true value 80 times of 100, with the bounds 94
    times (tests/test_reports_budget.py).

    >>> limit = extrapolate(Refinement((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178)))
    >>> limit.kind, round(limit.value, 6), round(limit.uncertainty / 0.97050, 6)
    ('monotone', 0.9713, 0.001031)
    """
    kind = kind_of_sequence(refinement)
    n_meshes = len(refinement.values)
    finest_value = refinement.values[0]
    # an extrapolation: order, kind, value at size zero, its uncertainty, the rule in words
    if n_meshes == 1:
        return Extrapolation(None, kind, None, None, "a single solution says nothing")
    if refinement.spread <= refinement.rounding:
        rule = "all solutions agree to rounding"
        return Extrapolation(None, kind, finest_value, refinement.rounding, rule)
    if n_meshes == 2:
        # value at size zero minus value of the finest mesh
        correction = _richardson_correction(refinement, refinement.formal_order)
        value_at_zero = finest_value + correction
        uncertainty = _LARGE_SAFETY_FACTOR * abs(correction)
        rule = "formal order assumed, safety factor 3"
        return Extrapolation(None, kind, value_at_zero, uncertainty, rule)

    # the observed order of every three neighbouring meshes, the finest three first
    orders = []
    for first_mesh in range(n_meshes - 2):
        three_meshes = slice(first_mesh, first_mesh + 3)
        orders.append(
            observed_order(refinement.sizes[three_meshes], refinement.values[three_meshes])
        )
    plausible_orders = [
        order for order in orders if order is not None and refinement.is_plausible(order)
    ]
    if len(plausible_orders) == len(orders):
        lowest_order = min(plausible_orders)
        if max(plausible_orders) - lowest_order <= refinement.formal_order / 4:
            finest_order = plausible_orders[0]
            value_at_zero = finest_value + _richardson_correction(refinement, finest_order)
            uncertainty = _SAFETY_FACTOR * abs(_richardson_correction(refinement, lowest_order))
            rule = "Roache, safety factor 1.25"
            return Extrapolation(finest_order, kind, value_at_zero, uncertainty, rule)
    if n_meshes == 3:
        rule = "the finest, three times the spread"
        return Extrapolation(
            orders[0], kind, finest_value, _LARGE_SAFETY_FACTOR * refinement.spread, rule
        )
    return _extrapolation_by_least_squares(refinement, kind)


def _richardson_correction(refinement: Refinement, order: float) -> float:
    """Value at size zero minus finest value, by Richardson's extrapolation with the order p from
    the two finest solutions: (phi_1 - phi_2) / ((h_2/h_1)^p - 1).
    """
    finest_value, second_value = refinement.values[:2]
    log_ratio = math.log(refinement.sizes[1] / refinement.sizes[0])
    return (finest_value - second_value) / math.expm1(order * log_ratio)


@dataclass(frozen=True)
class _FittedCurve:
    """A curve through scattered solutions."""

    value_at_zero: float  # at size zero
    finest_value: float  # its value at the finest size
    deviation: float  # standard deviation of the solutions from it
    order: float | None = None  # where the order was fitted too


def _extrapolation_by_least_squares(refinement: Refinement, kind: _Kind) -> Extrapolation:
    """Value at size zero and its uncertainty, from a curve fitted to four or more solutions (Eca
    and Hoekstra 2014, section 3).

    `kind` is "monotone", "oscillating" or "diverging". The uncertainty of monotone values is at
    least the spread of the three finest, otherwise at least the spread of all. Values that are not
    monotone have none: the value of the finest mesh stands for it.

    Three terms are added: the error of the curve at the finest size times a safety factor, the
    standard deviation of the values from the curve, and the distance of the finest value from it.
    The safety factor is 1.25 for a plausible order, else 3. The spread over the number of
    refinements is the mean change from mesh to mesh, if the values are monotone. Where the standard
    deviation is no less than it, 3 times the quotient of the two is the factor instead, on all
    three terms.
    """
    # curve of the fitted order, if that lies between a quarter of the formal order and the formal;
    # else of the formal order, half of it or both: its value at size zero, its value at the
    # finest size, and the standard `deviation` of the solutions from it
    curve, order_in_words, order = _trusted_curve(refinement)
    value_of_finest_mesh = refinement.values[0]
    # between neighbouring meshes, of monotone values; taken for others too, which change by more
    mean_change = refinement.spread / (len(refinement.values) - 1)
    residual_of_finest_value = abs(value_of_finest_mesh - curve.finest_value)
    error_of_finest_value = abs(curve.value_at_zero - curve.finest_value)
    safety_factor = _SAFETY_FACTOR if refinement.is_plausible(order) else _LARGE_SAFETY_FACTOR
    uncertainty = safety_factor * error_of_finest_value + curve.deviation + residual_of_finest_value
    if curve.deviation >= mean_change:  # the solutions scatter more than they change
        scatter_factor = _LARGE_SAFETY_FACTOR * curve.deviation / mean_change
        uncertainty = scatter_factor * (
            error_of_finest_value + curve.deviation + residual_of_finest_value
        )
    if kind == "monotone":
        spread_of_finest_three = max(refinement.values[:3]) - min(refinement.values[:3])
        uncertainty = max(uncertainty, spread_of_finest_three)
        rule = f"least squares, {order_in_words}"
        return Extrapolation(order, kind, curve.value_at_zero, uncertainty, rule)
    uncertainty = max(uncertainty, refinement.spread)
    rule = f"the finest; scatter about {order_in_words}"
    return Extrapolation(None, kind, value_of_finest_mesh, uncertainty, rule)


def _trusted_curve(refinement: Refinement) -> tuple[_FittedCurve, str, float | None]:
    """The curve of the values phi over the element size h that gives the value at size zero of a
    refinement study; its order in words; and the fitted order, None where no order from 0.01 to 16
    fits best.

    It is the curve of fitted order where that lies between a quarter of the formal order and the
    formal order. Otherwise it is the best of the curves with the formal order, with half of it, or
    (where the fitted order is small or absent) with both: the one with the least standard deviation
    of the solutions from it. Each is fitted with equal weights and with weights 1/h.
    """
    formal_order = refinement.formal_order  # of the method in theory
    curve_of_free_order = _best_curve_of_free_order(refinement)
    order = curve_of_free_order.order
    if order is not None and formal_order / 4 <= order <= formal_order:
        return curve_of_free_order, f"order {order:.2f}", order
    # exponents of h in each curve
    exponents_of_curves: list[tuple[float, ...]] = [(formal_order / 2,), (formal_order,)]
    if order is None or order < formal_order / 4:
        exponents_of_curves.append((formal_order / 2, formal_order))
    curves_and_exponents = [
        (_fitted_curve(refinement, exponents, weights), exponents)
        for exponents in exponents_of_curves
        for weights in _two_sets_of_weights(refinement)
    ]
    best_curve, best_exponents = min(
        curves_and_exponents, key=lambda curve_and_exponents: curve_and_exponents[0].deviation
    )
    exponents_in_words = " and ".join(f"{exponent:g}" for exponent in best_exponents)
    return best_curve, f"order {exponents_in_words} assumed", order


def _best_curve_of_free_order(refinement: Refinement) -> _FittedCurve:
    """The curve of fitted order, with the one of the two sets of weights that deviates less."""
    curves = [
        _curve_of_free_order(refinement, weights) for weights in _two_sets_of_weights(refinement)
    ]
    return min(curves, key=lambda curve: curve.deviation)


def _two_sets_of_weights(refinement: Refinement) -> Iterator[Array]:
    """Two sets of weights of the solutions, (k,) each, of mean 1: equal weights, and 1/h."""
    h = np.array(refinement.sizes)
    yield np.ones_like(h)
    yield len(h) / h / np.sum(1 / h)


def _order_of_best_curve(refinement: Refinement) -> float | None:
    """Order p of the curve that fits the values best; None where no p from 0.01 to 16 does."""
    if len(refinement.values) == 3:
        return observed_order(refinement.sizes, refinement.values)
    return _best_curve_of_free_order(refinement).order


def _curve_of_free_order(refinement: Refinement, weights: Array) -> _FittedCurve:
    """The curve phi_0 + alpha h^p that fits the values of a refinement study best, for `weights`
    (k,) of the k solutions: phi_0 the value at size zero, alpha a factor, p the order, between 0.01
    and 16. The order of the curve is None where the best p is an end of that range.

    `refinement` holds the sizes h and the values phi of the solutions, finest first. The returned
    curve has its value phi_0 at size zero, its value at the finest size, and the deviation of the
    solutions.
    """
    relative_sizes = np.array(refinement.sizes) / refinement.sizes[-1]  # over the coarsest
    values = np.array(refinement.values)
    centred_values = values - np.average(values, weights=weights)

    def sum_of_squares(orders: Array) -> Array:
        """Weighted sum of squared residuals of the curve phi_0 + alpha h^p from k values, with the
        best phi_0 and alpha, for each of m orders p: (m,).

        `relative_sizes` (k,) are h over the coarsest one, `centred_values` (k,) the values minus
        their weighted mean.
        """
        powers_of_size = relative_sizes ** np.atleast_1d(orders)[:, None]
        # (m, k), minus their mean: phi_0 drops out
        powers_of_size = (
            powers_of_size - np.average(powers_of_size, axis=1, weights=weights)[:, None]
        )
        alpha = (
            (weights * powers_of_size)
            @ centred_values
            / np.sum(weights * powers_of_size**2, axis=1)
        )
        residuals = centred_values - alpha[:, None] * powers_of_size
        return np.asarray(np.sum(weights * residuals**2, axis=1))

    # a search on 97 orders, then a closer one beside the best of them
    trial_orders = np.geomspace(*_RANGE_OF_SEARCHED_ORDERS, 97)
    best_index = int(np.argmin(sum_of_squares(trial_orders)))
    order = None
    if 0 < best_index < len(trial_orders) - 1:
        from scipy.optimize import minimize_scalar

        minimum = minimize_scalar(
            lambda trial_order: sum_of_squares(trial_order)[0],
            bounds=(float(trial_orders[best_index - 1]), float(trial_orders[best_index + 1])),
            method="bounded",
            options={"xatol": 1e-9},
        )
        order = float(minimum.x)
    best_order = order or float(trial_orders[best_index])
    return _fitted_curve(refinement, (best_order,), weights, order)


def _fitted_curve(
    refinement: Refinement, exponents: tuple[float, ...], weights: Array, order: float | None = None
) -> _FittedCurve:
    """Fit the curve phi_0 + sum_j alpha_j h^p_j to the solutions of a refinement study by weighted
    least squares; h are their sizes, p_j the `exponents`. Returns its value phi_0 at size zero, its
    value at the finest size, and the standard deviation of the solutions from it.

    Parameters
    ----------
    weights
        (k,) weights of the k solutions
    order
        the single exponent, where it was itself fitted; it then takes one degree of freedom more
    """
    relative_sizes = np.array(refinement.sizes) / refinement.sizes[-1]
    values = np.array(refinement.values)
    # (k, 1 + number of exponents): one column for phi_0, then one for each exponent
    design_matrix = np.column_stack(
        [np.ones_like(relative_sizes), *(relative_sizes**exponent for exponent in exponents)]
    )
    root_of_weights = np.sqrt(weights)
    coefficients = np.linalg.lstsq(
        design_matrix * root_of_weights[:, None], values * root_of_weights, rcond=None
    )[0]
    fitted_values = design_matrix @ coefficients
    n_fitted = len(coefficients) + (order is not None)  # numbers that were fitted
    degrees_of_freedom = max(len(values) - n_fitted, 1)
    deviation = math.sqrt(
        float(np.sum(weights * (values - fitted_values) ** 2)) / degrees_of_freedom
    )
    return _FittedCurve(float(coefficients[0]), float(fitted_values[0]), deviation, order)
