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
from reports.comparison.work_of_loads import on_straight_steps
from reports.python_numbers import PythonNumbers
from scenes import ContactSolution, ConvergenceError, InputError
from scenes.array_types import Array

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

ROUNDING = 1e-12  # relative: two values that differ by less are the same
# They are the step's part and the rest of another metric: a budget of them would count it twice.
_PARTS = ("dissipation_polygon", "dissipation_step")
# What `record.errors` of the reference says of a metric.
_FIELDS = {
    "largest_pressure": "pressure",
    "dissipation_density_peak": "dissipation_density",
    "peak_pressure": "pressure",
    "pressure": "pressure",
    "shear": "shear",
    "dissipation": "dissipation",
    "hysteresis": "dissipation",
    "dissipation_density": "dissipation_density",
}

# Metrics of the largest pressure, of a revolution and of an instant.
_PEAKS = ("largest_pressure", "peak_pressure")

# Of one stage: its name in, a context that yields report(done, total, text) out; `Stages.stage` is
# one.
_Stage = Callable[[str], AbstractContextManager[Callable[[int, int | None, str], None]]]

_BY_RUN = "uncertainty that the run itself states"

_LARGEST = 0.25  # of MeshSettings, over the contact half-width
_LEAST_RATIO = 1.2
# Radii of a half-disc, over the contact half-width, of which half and twice are radii that
# MeshSettings takes: 2 to 1000.
_FAR_RADII = (4.0, 500.0)


@dataclass(frozen=True, eq=False)
class Run(PythonNumbers):
    """One run of a refinement study: one size changed, everything else fixed."""

    label: str  # "2h", "L/2": what is different from the run
    size: float  # that size over the run's; of the far field 1/L
    # metric -> its value without the error of the steps; empty where the run failed
    values: Mapping[str, float | None]
    failure: str = ""  # why there are none
    # steps, nodes: of the path, of the contact
    steps: int = 0
    nodes: int = 0


@dataclass(frozen=True, eq=False)
class Refinements(PythonNumbers):
    """Every run by the term that it measures."""

    mesh: tuple[Run, ...]  # at h and coarser
    # at 2 L, L, L/2 on the coarse mesh, empty for bodies with a size of their own
    far_field: tuple[Run, ...]
    # (with the layer, without) on the run's own mesh and on the next coarser one; empty where the
    # law is met exactly
    penalty: tuple[tuple[Run, Run], ...]
    coarse: str  # label of the mesh on which all but the mesh refinement stand
    not_measured: Mapping[str, str]  # term -> why
    seconds: float  # CPU time of all but the run itself
    # with the increments of the run and with halved ones, on the coarse mesh, where theory has no
    # answer on the polygon of the increments, so that no value is without their error; None where
    # it has
    step: tuple[Run, ...] | None = None


# Fields of theory on the straight lines between the instants that the page and comparison.json show
# without a budget.
SHOWN_ON_STEPS = ("pressure", "dissipation", "loop_work")


def theory_on_steps(
    result: ContactSolution, fields: Sequence[str] | None = None
) -> ContactSolution | None:
    """Half-plane theory for a result's scene with loads that run straight from one instant of the
    result to the next, at the result's surface points.

    The result minus this answer holds no error of the load increments. None where bulk stress or
    tilt leave theory without an answer on such a path. `fields` are those of theory that are
    wanted: all of them by default, which a budget of the errors needs.
    """
    import semi_analytic

    scene = result.scene
    wanted_fields = semi_analytic.FIELDS if fields is None else fields
    try:
        # A thinned result, of a long path of straight lines, holds some of its instants only:
        # theory follows that path itself.
        return semi_analytic.solve(
            scene,
            x=result.x,
            time=result.time,
            fields=wanted_fields,
            straight_steps=not result.thinned,
        )
    except InputError:
        if scene.unsymmetric:
            return None
        raise


def without_steps(comparison: Comparison) -> dict[str, float | None]:
    """Value of each metric, by its key, without the error of the load increments: a result compared
    with theory on the result's own straight increments.

    Where bulk stress or tilt leave theory no such answer it is compared with theory on the smooth
    path. InputError where the comparison lacks theory on straight increments for another reason.
    """
    if comparison.polygon_reference is None and not (
        comparison.has_bulk_stress or comparison.may_tilt
    ):
        raise InputError(
            "a budget needs the reference on the polygon of the result's steps: give compare"
            " polygon_reference"
        )
    if comparison.polygon_reference is None:
        return _value_by_key(
            compare(comparison.reference, comparison.result, effects=comparison.effects)
        )
    result_on_polygon = on_straight_steps(comparison.result)
    return _value_by_key(
        compare(comparison.polygon_reference, result_on_polygon, effects=comparison.effects)
    )


def finer_steps(settings: SolverSettings) -> SolverSettings:
    """Increments half as long: their error is a quarter."""
    return replace(
        settings,
        steps_per_cycle=2 * settings.steps_per_cycle,
        step_tolerance=max(settings.step_tolerance / 4, 1e-8),
    )


def _value_by_key(comparison: Comparison) -> dict[str, float | None]:
    """Metric -> value."""
    return {metric.key: metric.value for metric in comparison.metrics}


def mesh_ratio(mesh: MeshSettings) -> float | None:
    """Ratio of element sizes of neighbouring meshes in a refinement study: 2, or less where three
    coarsenings by 2 would make elements too large. None where less than 1.2 is left.

    >>> from meshes import MeshSettings
    >>> (
    ...     mesh_ratio(MeshSettings()),
    ...     mesh_ratio(MeshSettings(element_size=0.2, edge_element_size=0.2)),
    ... )
    (2.0, None)
    """
    largest_ratio = (_LARGEST / mesh.edge_element_size) ** (1 / 3)
    if largest_ratio < _LEAST_RATIO:
        return None
    return min(2.0, largest_ratio)


def coarser(
    mesh: MeshSettings, settings: SolverSettings, factor: float
) -> tuple[MeshSettings, SolverSettings]:
    """Settings of mesh and solver for a mesh with all surface elements `factor` times larger, but
    at most 0.25 a, a the half-width of the contact.

    The stiffnesses of a penalty layer are multiplied by the factor too. They are stated relative to
    the elements, and so the layer itself stays as stiff wherever no size is limited.
    """
    middle_size = min(_LARGEST, factor * mesh.element_size)
    edge_size = min(_LARGEST, factor * mesh.edge_element_size)
    if settings.method == "penalty":
        normal_stiffness, tangential_stiffness = settings.stiffnesses
        settings = replace(
            settings,
            normal_stiffness=factor * normal_stiffness,
            tangential_stiffness=factor * tangential_stiffness,
        )
    return replace(mesh, element_size=middle_size, edge_element_size=edge_size), settings


def climb(
    comparison: Comparison,
    mesh: MeshSettings,
    settings: SolverSettings,
    stage: _Stage,
    coarsenings: int = 3,
) -> Refinements:
    """Solve a scene again by finite elements on coarser meshes, with other far fields, load
    increments or penalty layers: all that measures the errors of a run with this `mesh` and these
    `settings`.

    With three coarser meshes, their size ratio r, the runs are h, r h, r^2 h, r^3 h, h the element
    size of the run. Two coarser meshes are the least that shows an order, at a third of the cost.
    The far field, a half-disc of finite radius in place of a half-plane, is measured at r^2 h. A
    penalty layer, springs that let the faces overlap and creep, is measured at h and r h.

    Parameters
    ----------
    comparison
        the run against half-plane theory
    stage
        reports progress: a context for each run, by its label
    coarsenings
        number of coarser meshes, 2 or 3
    """
    start_seconds = time.process_time()
    ratio = mesh_ratio(mesh)
    base_run = Run(
        label="h",
        size=1.0,
        values=without_steps(comparison),
        failure="",
        steps=len(comparison.result.time),
        nodes=len(comparison.result.x),
    )
    if ratio is None:
        return _no_refinements(base_run, comparison)
    solver = _RunSolver(comparison, stage)
    mesh_runs = [base_run]
    for exponent in range(1, coarsenings + 1):
        size = ratio**exponent
        coarser_mesh, coarser_settings = coarser(mesh, settings, size)
        mesh_runs.append(solver.run(f"{size:.3g}h", size, coarser_mesh, coarser_settings))

    coarse_run = mesh_runs[2]
    coarse_mesh, coarse_settings = coarser(mesh, settings, ratio**2)
    far_field_runs: tuple[Run, ...] = ()
    not_measured: dict[str, str] = {}
    bodies = comparison.scene.bodies
    if "half_plane" in (bodies.lower.kind, bodies.upper.kind):
        if _FAR_RADII[0] <= mesh.far_radius <= _FAR_RADII[1]:
            far_field_runs = _far_field_runs(solver, coarse_run, coarse_mesh, coarse_settings)
        else:
            not_measured["far field"] = (
                f"a half-disc of radius {mesh.far_radius:g} a leaves no room for one of half and"
                " one of twice"
            )
    step_runs: tuple[Run, ...] | None = None
    # theory has no answer on the increments of a run: their error is measured by halving them
    if not solver.on_polygon:
        step_runs = (coarse_run, _finer_steps_run(solver, coarse_run, coarse_mesh, coarse_settings))
    penalty_pairs: tuple[tuple[Run, Run], ...] = ()
    if settings.method == "penalty":
        penalty_pairs = _penalty_runs(solver, mesh_runs[:2], mesh, settings)
    return Refinements(
        mesh=tuple(mesh_runs),
        far_field=far_field_runs,
        penalty=penalty_pairs,
        coarse=coarse_run.label,
        not_measured=not_measured,
        seconds=time.process_time() - start_seconds,
        step=step_runs,
    )


def _no_refinements(base_run: Run, comparison: Comparison) -> Refinements:
    """A refinement study of one run alone, for a mesh whose elements are so large that three
    coarser meshes are not possible; for each kind of error that is stated as the reason why it was
    not measured.

    Parameters
    ----------
    base_run
        the run whose errors would be measured
    """
    reason = "the run's own elements leave no room for three coarser meshes"
    return Refinements(
        mesh=(base_run,),
        far_field=(),
        penalty=(),
        coarse="none",
        not_measured=dict.fromkeys(("mesh", "far field", "penalty"), reason),
        seconds=0.0,
        step=() if comparison.polygon_reference is None else None,
    )


class _RunSolver:
    """Solves the runs of a refinement study, each compared with half-plane theory.

    Attributes
    ----------
    on_polygon
        whether theory follows the polygon of each run's own increments; else the smooth path
    """

    def __init__(self, comparison: Comparison, stage: _Stage) -> None:
        self.scene = comparison.scene
        self.effects = comparison.effects
        self.scales = getattr(comparison.result, "scales", None)
        self.on_polygon = comparison.polygon_reference is not None
        self.stage = stage

    def run(self, label: str, size: float, mesh: MeshSettings, settings: SolverSettings) -> Run:
        """Solve the scene by finite elements with one mesh and its settings, and compare the answer
        with half-plane theory. Returns the value of each metric, or why there is none.

        Parameters
        ----------
        label
            name of the run, such as "2h"
        size
            what is refined, over that of the finest run: element size, or 1/radius of a half-disc
        """
        import halfplane_fe

        with self.stage(f"budget, {label}") as report:
            try:
                solution = halfplane_fe.solve(
                    self.scene, mesh, settings, report, scales=self.scales
                )
            except ConvergenceError as failure:
                return Run(label, size, {}, f"{label} did not converge: {failure}")
            reference = self._theory(solution)
        if reference is None:
            return Run(label, size, {}, f"{label}: half-plane theory has no answer on its steps")
        compared_solution = on_straight_steps(solution) if self.on_polygon else solution
        values = _value_by_key(compare(reference, compared_solution, effects=self.effects))
        return Run(label, size, values, "", len(solution.time), len(solution.x))

    def _theory(self, solution: ContactSolution) -> ContactSolution | None:
        """Half-plane theory at the points and instants of a run; None where it has no answer."""
        import semi_analytic

        if self.on_polygon:
            return theory_on_steps(solution)
        return semi_analytic.solve(self.scene, x=solution.x, time=solution.time)


def _finer_steps_run(
    solver: _RunSolver, coarse_run: Run, mesh: MeshSettings, settings: SolverSettings
) -> Run:
    """The run on the coarse `mesh` with load increments of half the length of `settings`."""
    label = f"{coarse_run.label}, halved increments"
    return solver.run(label, coarse_run.size, mesh, finer_steps(settings))


def _far_field_runs(
    solver: _RunSolver, coarse_run: Run, mesh: MeshSettings, settings: SolverSettings
) -> tuple[Run, ...]:
    """Three runs that show what the finite radius L of a meshed half-disc, in place of a
    half-plane, does to a result: with the radius 2 L, L and L/2.

    `coarse_run` is the run with the radius L, solved already with this `mesh` and these `settings`.
    Sizes of the runs are 1/radius over 1/L: 0.5, 1 and 2.
    """
    runs = []
    for radius_in_words, inverse_radius in (("2 L", 0.5), ("L/2", 2.0)):
        scaled_mesh = replace(mesh, far_radius=mesh.far_radius / inverse_radius)
        label = f"{coarse_run.label}, {radius_in_words}"
        runs.append(solver.run(label, inverse_radius, scaled_mesh, settings))
    run_with_large_disc, run_with_small_disc = runs
    return (run_with_large_disc, replace(coarse_run, size=1.0), run_with_small_disc)


def _penalty_runs(
    solver: _RunSolver, runs: Iterable[Run], mesh: MeshSettings, settings: SolverSettings
) -> tuple[tuple[Run, Run], ...]:
    """Pairs of runs that show the error of a penalty layer: each of `runs`, and a run on the same
    mesh in which Coulomb's law is met exactly.

    `runs` are those on the finest mesh and the next coarser one; the second pair shows what the
    mesh does to the difference. Still coarser meshes would not show it: on them W changes more by
    where in an element an edge lies than by the layer.

    Parameters
    ----------
    solver
        solves the scene on a mesh and gives the run
    settings
        solver settings of the runs
    """
    exact_settings = replace(
        settings, method="active_set", normal_stiffness=None, tangential_stiffness=None
    )
    pairs = []
    for run in runs:
        mesh_of_run, _ = coarser(mesh, settings, run.size)
        label = f"{run.label}, law met exactly"
        pairs.append((run, solver.run(label, run.size, mesh_of_run, exact_settings)))
    return tuple(pairs)


@dataclass(frozen=True)
class Term(PythonNumbers):
    """One source of error in one metric."""

    name: str  # "mesh", "step", ...
    # its share of the metric, signed; None where nothing stands out of the scatter, or nothing was
    # measured
    value: float | None
    uncertainty: float | None  # of that share; None where nothing was measured
    how: str  # by what it was measured, or why not
    # the uncertainty is one that is never exceeded: bounds add up, the others go by the root of the
    # sum of squares
    bound: bool = False
    # order, kind: of the refinement, where it has one
    order: float | None = None
    kind: str = ""

    @property
    def measured(self) -> bool:
        """Whether anything is known of it."""
        return self.uncertainty is not None


@dataclass(frozen=True)
class Budget:
    """The error of one metric and where it comes from."""

    metric: Metric  # the whole error, with its tolerance
    terms: tuple[Term, ...]  # every source but the idealisation
    # whether the bodies are the half-planes of theory, so that there is no idealisation, see
    # `are_half_planes`
    half_planes: bool

    @property
    def total(self) -> float:
        """E: what the metric says."""
        return float("nan") if self.metric.value is None else self.metric.value

    @property
    def rest(self) -> float:
        """What the measured errors leave of the difference: the idealisation error, or of
        half-planes what is unexplained.
        """
        return self.total - sum(term.value or 0.0 for term in self.terms)

    @property
    def uncertainty(self) -> float | None:
        """u of the rest; None where a term was not measured."""
        if not all(term.measured for term in self.terms):
            return None
        bounds = [term.uncertainty or 0.0 for term in self.terms if term.bound]
        estimates = [term.uncertainty or 0.0 for term in self.terms if not term.bound]
        return math.hypot(*estimates) + sum(bounds)

    @property
    def judged(self) -> Metric:
        """The metric with u for its uncertainty; as it is where u is not known."""
        if self.uncertainty is None:
            return self.metric
        return replace(self.metric, uncertainty=self.uncertainty)

    @property
    def resolved(self) -> bool | None:
        """Whether an idealisation error stands out, |rest| > u; None where that is not known."""
        if self.uncertainty is None or not math.isfinite(self.rest):
            return None
        return abs(self.rest) > self.uncertainty

    @property
    def honest(self) -> bool | None:
        """Whether the stated uncertainty covers the error: known for half-planes only, where the
        rest must be nothing.
        """
        if not self.half_planes or self.resolved is None:
            return None
        return not self.resolved


@dataclass(frozen=True, eq=False)
class ErrorBudget:
    """Budgets of all metrics, the runs they rest on, and CPU seconds of the plain run and of
    these.
    """

    budgets: tuple[Budget, ...]
    refinements: Refinements
    plain_seconds: float

    @property
    def cost(self) -> float:
        """CPU time of the run with its budget over that of the plain run."""
        return 1 + self.refinements.seconds / self.plain_seconds

    def budget(self, key: str) -> Budget:
        """The budget of a metric; KeyError where it has none."""
        return {budget.metric.key: budget for budget in self.budgets}[key]

    @property
    def honest(self) -> str:
        """A sentence: of how many metrics the stated uncertainty covers what the measured errors
        leave unexplained. `Budget.honest` is the truth value for one metric. That can be checked
        only where the exact answer of the bodies is known.
        """
        coverings_known = [budget.honest for budget in self.budgets if budget.honest is not None]
        if not coverings_known:
            return (
                "cannot be checked here: the exact answer of these bodies is unknown (that of"
                " half-planes is known)"
            )
        return (
            f"{sum(coverings_known)} of {len(coverings_known)} metrics: the stated uncertainty"
            " covers what the measured terms leave unexplained"
        )


def error_budget(
    comparison: Comparison, refinements: Refinements, plain_seconds: float
) -> ErrorBudget:
    """For every metric of `comparison` with a finite value, the part of each source of error in it:
    mesh, penalty layer, load increments, far field, iteration, theory.

    `plain_seconds` is the CPU time of the run without the refinements.
    """
    has_exact_answer = are_half_planes(comparison.scene)
    iteration_term = _solver(comparison)
    budgets = []
    for metric in comparison.metrics:
        if metric.key in _PARTS or metric.value is None or not math.isfinite(metric.value):
            continue
        terms = (
            _mesh(metric, comparison, refinements),
            _penalty(metric, comparison, refinements),
            _step(metric, refinements),
            _far_field(metric, comparison, refinements),
            iteration_term,
            _theory(metric, comparison),
        )
        budgets.append(Budget(metric, terms, has_exact_answer))
    return ErrorBudget(tuple(budgets), refinements, plain_seconds)


def _sizes_and_values(metric: Metric, runs: Iterable[Run]) -> list[tuple[float, float]]:
    """Size and value of the runs that have a finite one."""
    pairs = []
    for run in runs:
        value = run.values.get(metric.key)
        if value is not None and math.isfinite(value):
            pairs.append((run.size, value))
    return pairs


def _not_measured(name: str, runs: Iterable[Run] = (), why: str = "", before: str = "") -> Term:
    """A term that nothing is known of: why, or what the runs failed by."""
    failures = "; ".join(run.failure for run in runs if run.failure)
    reason = why or failures or "a run has no finite value"
    return Term(name, None, None, f"not measured: {before}{reason}")


def _term_by_extrapolation(
    name: str, metric: Metric, refinements: Refinements, runs: tuple[Run, ...], formal_order: float
) -> Term:
    """The error of a metric by one kind of refinement: its value in the run itself (size 1) minus
    the limit of `runs` at size zero. No value where the values only scatter.

    Parameters
    ----------
    name
        kind of error: "mesh" or "far field"
    refinements
        states, by kind of error, why one was not measured
    runs
        runs that differ in one size only
    formal_order
        order of convergence that the method has in theory
    """
    value_at = dict(_sizes_and_values(metric, runs))
    if name in refinements.not_measured or len(value_at) < 3 or 1.0 not in value_at:
        return _not_measured(name, runs, refinements.not_measured.get(name, ""))
    limit = extrapolate(
        Refinement(tuple(value_at), tuple(value_at.values()), formal_order, ROUNDING)
    )
    error_of_run = None
    if limit.kind not in ("oscillating", "diverging"):
        error_of_run = value_at[1.0] - (limit.value or 0.0)
    return Term(
        name, error_of_run, limit.uncertainty, limit.rule, order=limit.order, kind=limit.kind
    )


def _mesh(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """The error that the mesh makes in a metric: value of the run minus its limit for size zero.

    A run that states an uncertainty of the value passes it on, since a value and its difference
    from theory are equally uncertain. The coarser meshes then state the error, where they know it
    better. They state both where the run states nothing, and where their curve ends outside of what
    it states.
    """
    term = _term_by_extrapolation("mesh", metric, refinements, refinements.mesh, 2.0)
    if term.uncertainty is None:
        return term
    labels = ", ".join(run.label for run in refinements.mesh if not run.failure)
    method = f"{labels}: {term.kind}; {term.how}"
    stated_uncertainty = _stated_by_mesh(metric, comparison)
    if stated_uncertainty is None:
        return _no_less_than_stated(replace(term, how=method), metric, comparison)
    if term.value is not None and abs(term.value) > stated_uncertainty:
        return replace(term, how=f"{method}; the run itself states less, {stated_uncertainty:.1e}")
    if stated_uncertainty < term.uncertainty:
        # Where edges stand in their elements moves a value from mesh to mesh: a few meshes show
        # that scatter, and no order.
        method = (
            f"{method}, {term.uncertainty:.1e}; instead the smaller uncertainty that the run itself"
            " states"
        )
        return Term("mesh", None, stated_uncertainty, method)
    return replace(term, uncertainty=stated_uncertainty, how=f"{method}; {_BY_RUN}")


def _no_less_than_stated(term: Term, metric: Metric, comparison: Comparison) -> Term:
    """The mesh's contribution `term` to a metric, with an uncertainty no smaller than what the run
    itself states of its contact edges, stick edges and pressure peaks.

    It is used for metrics whose own value has no stated uncertainty.
    """
    least_uncertainty = max(
        metric.uncertainty or 0.0,
        _stated_of_edges(metric, comparison),
        _stated_of_peak(metric, comparison),
    )
    if (term.uncertainty or 0.0) < least_uncertainty < math.inf:
        return replace(term, uncertainty=least_uncertainty, how=f"{term.how}; {_BY_RUN}")
    return term


def _stated_by_mesh(metric: Metric, comparison: Comparison) -> float | None:
    """Uncertainty by the mesh that the result states of the value, in the unit of the metric; None
    without one, and of a penalty layer, whose own share is a part of it.
    """
    if comparison.result.settings.get("solver", {}).get("method") == "penalty":
        return None
    return metric.stated_by_result


def _stated_of_edges(metric: Metric, comparison: Comparison) -> float:
    """Uncertainty that a result itself states of a contact or stick edge at the instant at which
    the metric was taken, over the reference half-width. 0 for metrics of no edge, and where none is
    stated.
    """
    result = comparison.result
    edge_uncertainty = getattr(result, f"{metric.key}_uncertainty", None)
    # no edge: the largest pressure, whose uncertainty has the same kind of name
    if metric.key in _PEAKS or edge_uncertainty is None or metric.time is None:
        return 0.0
    instant = int(abs(result.time - metric.time).argmin())
    return float(max(edge_uncertainty[instant])) / comparison.scales.half_width


def _stated_of_peak(metric: Metric, comparison: Comparison) -> float:
    """Uncertainty that the result states of its largest pressure, over the reference's; 0 for
    metrics that are no peak, for half-planes, and where none is stated.

    It is added because the coarser meshes of a budget may agree by chance: the peak is a smooth
    function of the element size only where the edges of contact lie alike in their elements. For
    half-planes it is not needed: their true error is known, and what those meshes show covers it.

    The result states it over its own peak. The value of a metric is result/reference - 1: with 1
    plus that value it is over the reference's peak.
    """
    if metric.key not in _PEAKS or are_half_planes(comparison.scene):
        return 0.0
    uncertainty = comparison.result.uncertainties.get("largest_pressure", math.nan)
    if not math.isfinite(uncertainty):
        return 0.0
    uncertainty_over_result = float(uncertainty / comparison.result.pressure.max())
    return uncertainty_over_result * abs(1 + (metric.value or 0.0))


def _step(metric: Metric, refinements: Refinements) -> Term:
    """The error that straight load increments make in a metric: exact where theory steps through
    the same increments.

    Elsewhere 4/3 of what halved increments change, by second order, and as uncertain as that
    change.
    """
    if refinements.step is not None:
        values = [value for _, value in _sizes_and_values(metric, refinements.step)]
        if len(values) < 2:
            reason_before = "half-plane theory has no answer on the polygon of the steps, and "
            return _not_measured("step", refinements.step, before=reason_before)
        # run with the increments of the result minus run with halved ones
        change = values[0] - values[1]
        method = (
            f"halved increments at {refinements.coarse}, second order; half-plane theory has no"
            " answer on the polygon of the steps"
        )
        return Term("step", 4 / 3 * change, abs(change) + ROUNDING, method)
    value_on_polygon = refinements.mesh[0].values.get(metric.key)
    if value_on_polygon is None or not math.isfinite(value_on_polygon) or metric.value is None:
        return _not_measured("step", why="theory on the polygon of the steps has no such value")
    method = (
        "exact: half-plane theory on the smooth path against itself on the polygon of the steps"
    )
    return Term("step", metric.value - value_on_polygon, ROUNDING, method, bound=True)


def _penalty(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """The error that a penalty layer makes in a metric: value with the layer minus value without
    it.

    Its uncertainty is twice what the next coarser mesh changes of that difference. None, and exact,
    without a layer.
    """
    if comparison.result.settings.get("solver", {}).get("method") != "penalty":
        method = "none by construction: the law is met exactly"
        return Term("penalty", None, 0.0, method, bound=True)
    differences = []
    for run_pair in refinements.penalty:
        values = [value for _, value in _sizes_and_values(metric, run_pair)]
        if len(values) == 2:
            value_with_layer, value_without_layer = values
            differences.append(value_with_layer - value_without_layer)
    if "penalty" in refinements.not_measured or len(differences) < 2:
        reason = refinements.not_measured.get("penalty", "")
        return _not_measured("penalty", chain(*refinements.penalty), reason)
    method = (
        "with the layer less without it, at h; twice what that changes by at the next coarser mesh"
    )
    return Term("penalty", differences[0], 2 * abs(differences[0] - differences[1]), method)


def _far_field(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """The error that the finite radius L of a meshed half-plane makes in a metric: phi(L) −
    phi(infinity) on the coarse mesh, phi the metric.

    Where the radii show no order their scatter is its uncertainty.
    """
    if "half_plane" not in (comparison.scene.bodies.lower.kind, comparison.scene.bodies.upper.kind):
        return Term("far field", None, 0.0, "none: the bodies have a size of their own", bound=True)
    term = _term_by_extrapolation("far field", metric, refinements, refinements.far_field, 4.0)
    if term.uncertainty is None:
        return term
    method = f"radius 2 L, L, L/2 on the mesh of {refinements.coarse}: {term.kind}"
    # Tractions under given loads converge with the fourth power of 1/L.
    if term.kind == "exact" or _plausible(term.order, 4.0):
        return replace(term, how=method)
    values = [value for _, value in _sizes_and_values(metric, refinements.far_field)]
    method += "; not resolved: the scatter between meshes is as large"
    return replace(term, value=None, uncertainty=max(values) - min(values), how=method)


def _solver(comparison: Comparison) -> Term:
    """The worst residual of any step: dimensionless, a bound for what rounding and termination may
    do.
    """
    checks = [check for check in comparison.result_certificates if check.source == "record"]
    if not checks:
        return _not_measured("solver", why="the result states no residuals")
    worst_check = max(checks, key=lambda check: check.value)
    method = f"worst residual of any step: {worst_check.name}"
    return Term("solver", None, worst_check.value, method, bound=True)


def _theory(metric: Metric, comparison: Comparison) -> Term:
    """The error of half-plane theory's own quadratures and series in a metric, as theory's record
    estimates it; round-off where it uses closed forms. There is no value: the sign is not known.
    """
    field = _FIELDS.get(metric.key, metric.key)
    polygon = comparison.polygon_reference
    records = [comparison.reference.record]
    if polygon is not None:
        records.append(polygon.record)
    error_estimates = [
        error
        for record in records
        for name, error in record.errors.items()
        if name.startswith(field)
    ]
    if metric.stated_by_reference:
        error_estimates.append(metric.stated_by_reference)
    # without an estimate: closed forms
    uncertainty = ROUNDING
    method = "closed forms: rounding"
    if error_estimates:
        uncertainty = max(error_estimates) + ROUNDING
        method = "its own estimate of quadratures and series"
    return Term("half-plane theory", None, uncertainty, method, bound=True)


# --------------------------------------------------------------- mesh-refinement study of one value
_Kind = Literal["monotone", "oscillating", "diverging", "exact", "too few"]

# Safety factors on an uncertainty: of a plausible order, and of any other (Eca and Hoekstra 2014).
_SAFE = 1.25
_DOUBTFUL = 3.0
# Orders outside are looked for only to be told apart: beyond 16 a ratio of 2 leaves no digits
# between the two finest solutions.
_ORDERS = (0.01, 16.0)


@dataclass(frozen=True)
class Refinement(PythonNumbers):
    """Values of one quantity from solutions of different size, everything else fixed."""

    sizes: tuple[float, ...]  # h > 0 of each solution, finest first, strictly growing
    values: tuple[float, ...]  # phi of each solution, finite
    # largest order that theory admits; plausible ones lie between a quarter of it and a twentieth
    # above
    formal_order: float = 2.0
    rounding: float = 0.0  # differences up to this are none

    def __post_init__(self) -> None:
        """Check the sizes and values of a refinement study. ValueError for sizes that do not grow
        from the finest on, and for values that are not finite or not as many as sizes.
        """
        super().__post_init__()
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
        """Largest less least value."""
        return max(self.values) - min(self.values)

    def plausible(self, order: float | None) -> bool:
        """Whether theory admits an observed order."""
        return _plausible(order, self.formal_order)


def _plausible(order: float | None, formal: float) -> bool:
    """Whether theory admits an observed order, for the formal order 2 those from 0.5 to 2.1 (Eca
    and Hoekstra 2014).
    """
    return order is not None and formal / 4 <= order <= 1.05 * formal


@dataclass(frozen=True)
class Extrapolation(PythonNumbers):
    """What a refinement study says."""

    order: float | None  # observed p; None where there is none
    kind: _Kind  # how the values go as h falls
    value: float | None  # phi_0; None for a single solution
    # |phi_0 - truth| and |finest phi - truth| should both be less, about 19 times of 20; None for a
    # single solution
    uncertainty: float | None
    rule: str  # in words


def observed_order(sizes: tuple[float, ...], values: tuple[float, ...]) -> float | None:
    """Order of convergence p of three solutions: that of the curve phi_0 + alpha h^p through their
    values. None where the values are not monotone, or drift apart as the size h falls.

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
    # with p
    fine_change = values[1] - values[0]
    coarse_change = values[2] - values[1]
    if fine_change == 0 or coarse_change / fine_change <= 0:
        return None
    log_of_changes = math.log(coarse_change / fine_change)
    fine_log_ratio = math.log(sizes[1] / sizes[0])
    coarse_log_ratio = math.log(sizes[2] / sizes[1])

    def misfit(p: float) -> float:
        growth = math.expm1(p * coarse_log_ratio) / math.expm1(p * fine_log_ratio)
        return p * fine_log_ratio + math.log(growth) - log_of_changes

    least_order, largest_order = _ORDERS
    if misfit(least_order) >= 0 or misfit(largest_order) <= 0:
        return None
    from scipy.optimize import brentq  # a tenth of a second, for few comparisons

    return float(brentq(misfit, least_order, largest_order, xtol=1e-14))


def kind_of(refinement: Refinement) -> _Kind:
    """How the values of a refinement study change as the element size falls.

    All in one sense: monotone where a curve with p > 0 fits best, else diverging. In changing
    senses: oscillating where the last change is smaller than the largest before it, else diverging.
    """
    if len(refinement.values) < 3:
        return "too few"
    if refinement.spread <= refinement.rounding:
        return "exact"
    changes = np.diff(refinement.values)
    if np.all(changes > 0) or np.all(changes < 0):
        return "diverging" if _order(refinement) is None else "monotone"
    return "oscillating" if abs(changes[0]) < np.abs(changes[1:]).max() else "diverging"


def extrapolate(refinement: Refinement) -> Extrapolation:
    """Extrapolate a value to element size zero from solutions on meshes of different size: the
    order of convergence, the kind of sequence (monotone, oscillating, ...), the limit and its
    uncertainty.

    Where every three neighbouring meshes are monotone and their orders plausible and alike to a
    quarter of the formal one: Roache's index with the safety factor 1.25, the uncertainty by the
    lowest order. Monotone otherwise: least squares, not less than the spread of the three finest.
    Oscillating or diverging: the finest value, with no less than the spread of all. These floors
    are ours: of noise about as large as the trend, the published rules on four solutions cover four
    truths of five only, with the floors 94 of 100 (tests/test_reports_budget.py).

    >>> found = extrapolate(Refinement((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178)))
    >>> found.kind, round(found.value, 6), round(found.uncertainty / 0.97050, 6)
    ('monotone', 0.9713, 0.001031)
    """
    kind = kind_of(refinement)
    n_solutions = len(refinement.values)
    finest_value = refinement.values[0]
    if n_solutions == 1:
        return Extrapolation(None, kind, None, None, "a single solution says nothing")
    if refinement.spread <= refinement.rounding:
        rule = "all solutions agree to rounding"
        return Extrapolation(None, kind, finest_value, refinement.rounding, rule)
    if n_solutions == 2:
        correction = _richardson(refinement, refinement.formal_order)
        rule = "formal order assumed, safety factor 3"
        return Extrapolation(
            None, kind, finest_value + correction, _DOUBTFUL * abs(correction), rule
        )
    orders = []
    for first_mesh in range(n_solutions - 2):
        three_meshes = slice(first_mesh, first_mesh + 3)
        orders.append(
            observed_order(refinement.sizes[three_meshes], refinement.values[three_meshes])
        )
    plausible_orders = [
        order for order in orders if order is not None and refinement.plausible(order)
    ]
    if len(plausible_orders) == len(orders):
        lowest_order = min(plausible_orders)
        if max(plausible_orders) - lowest_order <= refinement.formal_order / 4:
            finest_order = plausible_orders[0]
            limit = finest_value + _richardson(refinement, finest_order)
            uncertainty = _SAFE * abs(_richardson(refinement, lowest_order))
            rule = "Roache, safety factor 1.25"
            return Extrapolation(finest_order, kind, limit, uncertainty, rule)
    if n_solutions == 3:
        rule = "the finest, three times the spread"
        return Extrapolation(orders[0], kind, finest_value, _DOUBTFUL * refinement.spread, rule)
    return _least_squares(refinement, kind)


def _richardson(refinement: Refinement, order: float) -> float:
    """phi_0 - phi_1 by Richardson's extrapolation from the two finest solutions."""
    finest_value, second_value = refinement.values[:2]
    log_ratio = math.log(refinement.sizes[1] / refinement.sizes[0])
    return (finest_value - second_value) / math.expm1(order * log_ratio)


@dataclass(frozen=True)
class _Fit:
    """A curve through scattered solutions: value at size zero, fitted finest value, standard
    deviation, order where it was free.
    """

    limit: float
    finest_value: float
    deviation: float
    order: float | None = None


def _least_squares(refinement: Refinement, kind: _Kind) -> Extrapolation:
    """Limit at size zero and its uncertainty, from a curve fitted to four or more solutions (Eca
    and Hoekstra 2014, section 3).

    The uncertainty is no less than the spread of the three finest solutions where all are monotone,
    else than the spread of all. Without a trend the value is that of the finest.

    Parameters
    ----------
    kind
        how the values change with the size: "monotone", "oscillating" or "diverging"
    """
    fit, order_in_words, order = _trusted_curve(refinement)
    finest_value = refinement.values[0]
    mean_change = refinement.spread / (len(refinement.values) - 1)
    residual = abs(finest_value - fit.finest_value)
    error_of_finest = abs(fit.limit - fit.finest_value)
    safety_factor = _SAFE if refinement.plausible(order) else _DOUBTFUL
    uncertainty = safety_factor * error_of_finest + fit.deviation + residual
    if fit.deviation >= mean_change:  # the solutions scatter more than they change
        scatter_factor = _DOUBTFUL * fit.deviation / mean_change
        uncertainty = scatter_factor * (error_of_finest + fit.deviation + residual)
    if kind == "monotone":
        spread_of_finest = max(refinement.values[:3]) - min(refinement.values[:3])
        uncertainty = max(uncertainty, spread_of_finest)
        rule = f"least squares, {order_in_words}"
        return Extrapolation(order, kind, fit.limit, uncertainty, rule)
    uncertainty = max(uncertainty, refinement.spread)
    rule = f"the finest; scatter about {order_in_words}"
    return Extrapolation(None, kind, finest_value, uncertainty, rule)


def _trusted_curve(refinement: Refinement) -> tuple[_Fit, str, float | None]:
    """The curve of a refinement study's values over element size that is used for the limit; its
    order in words; and the order that was observed, None where it is beyond the range searched.

    It is the curve of fitted order where this lies between a quarter of the formal order and the
    formal order; else the best of the curves with fixed orders.
    """
    formal_order = refinement.formal_order
    free_fit = _best_free_fit(refinement)
    order = free_fit.order
    if order is not None and formal_order / 4 <= order <= formal_order:
        return free_fit, f"order {order:.2f}", order
    powers_of_curves: list[tuple[float, ...]] = [(formal_order / 2,), (formal_order,)]
    if order is None or order < formal_order / 4:
        powers_of_curves.append((formal_order / 2, formal_order))
    fits = [
        (_fit(refinement, powers, weights), powers)
        for powers in powers_of_curves
        for weights in _weights(refinement)
    ]
    best_fit, best_powers = min(fits, key=lambda pair: pair[0].deviation)
    powers_in_words = " and ".join(f"{power:g}" for power in best_powers)
    return best_fit, f"order {powers_in_words} assumed", order


def _best_free_fit(refinement: Refinement) -> _Fit:
    """The curve of any order with the smaller deviation of the two weightings."""
    fits = [_fit_of_free_order(refinement, weights) for weights in _weights(refinement)]
    return min(fits, key=lambda fit: fit.deviation)


def _weights(refinement: Refinement) -> Iterator[Array]:
    """Equal ones, and 1/h; both of mean 1."""
    h = np.array(refinement.sizes)
    yield np.ones_like(h)
    yield len(h) / h / np.sum(1 / h)


def _order(refinement: Refinement) -> float | None:
    """Order of the best curve; None where it has p <= 0."""
    if len(refinement.values) == 3:
        return observed_order(refinement.sizes, refinement.values)
    return _best_free_fit(refinement).order


def _fit_of_free_order(refinement: Refinement, weights: Array) -> _Fit:
    """The curve phi_0 + alpha h^p that fits the values of a refinement study best with these
    `weights` (k,), p free between 0.01 and 16. Its order is None where the best p is an end of that
    range.
    """
    relative_sizes = np.array(refinement.sizes) / refinement.sizes[-1]
    values = np.array(refinement.values)
    deviations = values - np.average(values, weights=weights)

    def residual(orders: Array) -> Array:
        """Weighted sum of squares of the residuals with the best alpha, for each of some orders p,
        (k,).
        """
        powers = relative_sizes ** np.atleast_1d(orders)[:, None]
        powers = powers - np.average(powers, axis=1, weights=weights)[:, None]
        alpha = (weights * powers) @ deviations / np.sum(weights * powers**2, axis=1)
        return np.asarray(np.sum(weights * (deviations - alpha[:, None] * powers) ** 2, axis=1))

    trial_orders = np.geomspace(*_ORDERS, 97)
    best_index = int(np.argmin(residual(trial_orders)))
    order = None
    if 0 < best_index < len(trial_orders) - 1:
        from scipy.optimize import minimize_scalar

        minimum = minimize_scalar(
            lambda trial_order: residual(trial_order)[0],
            bounds=(float(trial_orders[best_index - 1]), float(trial_orders[best_index + 1])),
            method="bounded",
            options={"xatol": 1e-9},
        )
        order = float(minimum.x)
    return _fit(refinement, (order or float(trial_orders[best_index]),), weights, order)


def _fit(
    refinement: Refinement, powers: tuple[float, ...], weights: Array, order: float | None = None
) -> _Fit:
    """Fit the curve phi_0 + sum alpha_k h^p_k to the solutions of a refinement study by weighted
    least squares; h are their sizes, p_k the `powers`. Returns limit phi_0, finest value and
    standard deviation.

    Parameters
    ----------
    weights
        (k,) weights of the k solutions
    order
        the single power, where it was itself fitted; it then counts as a parameter
    """
    relative_sizes = np.array(refinement.sizes) / refinement.sizes[-1]
    values = np.array(refinement.values)
    terms = np.column_stack(
        [np.ones_like(relative_sizes), *(relative_sizes**power for power in powers)]
    )
    root_of_weights = np.sqrt(weights)
    coefficients = np.linalg.lstsq(
        terms * root_of_weights[:, None], values * root_of_weights, rcond=None
    )[0]
    fitted_values = terms @ coefficients
    degrees_of_freedom = max(len(relative_sizes) - len(coefficients) - (order is not None), 1)
    deviation = math.sqrt(
        float(np.sum(weights * (values - fitted_values) ** 2)) / degrees_of_freedom
    )
    return _Fit(float(coefficients[0]), float(fitted_values[0]), deviation, order)
