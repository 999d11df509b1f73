"""Where an error comes from, metric by metric: mesh, penalty, steps, far field, solver, half-plane theory's own, idealisation.

They add up to the metric. Every term is measured by itself, everything else fixed, on runs beside the run: coarser meshes, other
far fields, the contact law without a layer. These runs are compared with half-plane theory on the polygon of their own
increments, so that no step error is in them. What is left over is the idealisation; for half-planes there is none by construction,
and what is left over must be less than its own uncertainty, which tests the whole budget.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING

from reports.comparison import Comparison, Report, compare
from reports.comparison.convergence import Refinement, extrapolate, plausible
from reports.comparison.metrics import Metric, are_half_planes
from scenes import ContactSolution, ConvergenceError, InputError

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

ROUNDING = 1e-12
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


# Of one stage: its name in, a context that yields report(done, total, text) out; `Stages.stage` is one.
_Stage = Callable[[str], AbstractContextManager[Callable[[int, int | None, str], None]]]

_LARGEST = 0.25  # of MeshSettings, over the contact half-width
_LEAST_RATIO = 1.2


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a refinement study: one size changed, everything else fixed."""

    label: str  # "2h", "L/2": what is different from the run
    size: float  # that size over the run's; of the far field 1/L
    values: Mapping[str, float | None]  # metric -> its value without the error of the steps; empty where the run failed
    failure: str = ""  # why there are none
    # steps, nodes: of the path, of the contact
    steps: int = 0
    nodes: int = 0


@dataclass(frozen=True, eq=False)
class Refinements:
    """Every run by the term that it measures."""

    mesh: tuple[Run, ...]  # at h and coarser
    far_field: tuple[Run, ...]  # at 2 L, L, L/2 on the coarse mesh, empty for bodies with a size of their own
    # (with the layer, without) on the run's own mesh and on the next coarser one; empty where the law is met exactly
    penalty: tuple[tuple[Run, Run], ...]
    coarse: str  # label of the mesh on which all but the mesh refinement stand
    not_measured: Mapping[str, str]  # term -> why
    seconds: float  # CPU time of all but the run itself
    # with the increments of the run and with halved ones, on the coarse mesh, where theory has no answer on the polygon of the
    # increments, so that no value is without their error; None where it has
    step: tuple[Run, ...] | None = None


def theory_on_steps(result: ContactSolution) -> ContactSolution | None:
    """Half-plane theory on the straight lines between the instants of a result; None where bulk stress or tilt leave it none."""
    import semi_analytic

    scene = result.scene
    try:
        return semi_analytic.solve(scene, x=result.x, time=result.time, straight_steps=not result.thinned)
    except InputError:
        if scene.unsymmetric:
            return None
        raise


def without_steps(comparison: Comparison) -> dict[str, float | None]:
    """Metric -> value against theory on the polygon of the result's own increments; on the smooth path where it has no other."""
    if comparison.polygon_reference is None and not (comparison.pulled or comparison.turned):
        raise InputError("a budget needs the reference on the polygon of the result's steps: give compare polygon_reference")
    return _values(compare(comparison.polygon_reference or comparison.reference, comparison.result))


def finer_steps(settings: SolverSettings) -> SolverSettings:
    """Increments half as long: their error is a quarter."""
    return replace(settings, steps_per_cycle=2 * settings.steps_per_cycle, step_tolerance=max(settings.step_tolerance / 4, 1e-8))


def _values(comparison: Comparison) -> dict[str, float | None]:
    return {metric.key: metric.value for metric in comparison.metrics}


def mesh_ratio(mesh: MeshSettings) -> float | None:
    """Ratio of neighbouring runs: 2, or what three coarsenings leave room for; None where that is less than 1.2.

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


def climb(comparison: Comparison, mesh: MeshSettings, settings: SolverSettings, stage: _Stage, coarsenings: int = 3) -> Refinements:
    """Solve all that measures the errors of a run that was cut by `mesh` and iterated by `settings`.

    With three coarser meshes, their size ratio r, the runs are h, r h, r^2 h, r^3 h; with two, the least that shows an order, they
    cost a third of that. The far field is measured at r^2 h, a penalty layer at h and r h.
    """
    begun = time.process_time()
    missing: dict[str, str] = {}
    ratio = mesh_ratio(mesh)
    on_polygon = comparison.polygon_reference is not None
    own = Run("h", 1.0, without_steps(comparison), "", len(comparison.result.time), len(comparison.result.x))
    if ratio is None:
        why = "the run's own elements leave no room for three coarser meshes"
        return Refinements(
            (own,), (), (), "none", dict.fromkeys(("mesh", "far field", "penalty"), why), 0.0, None if on_polygon else ()
        )
    scene, scales = comparison.scene, getattr(comparison.result, "scales", None)

    def solved(label: str, size: float, mesh: MeshSettings, settings: SolverSettings) -> Run:
        import halfplane_fe
        import semi_analytic

        with stage(f"budget, {label}") as report:
            try:
                result = halfplane_fe.solve(scene, mesh, settings, report, scales=scales)
            except ConvergenceError as failure:
                return Run(label, size, {}, f"{label} did not converge: {failure}")
            reference = theory_on_steps(result) if on_polygon else semi_analytic.solve(scene, x=result.x, time=result.time)
        if reference is None:
            return Run(label, size, {}, f"{label}: half-plane theory has no answer on its steps")
        values = _values(compare(reference, result))
        return Run(label, size, values, "", len(result.time), len(result.x))

    sizes = [ratio**power for power in range(1, coarsenings + 1)]
    meshes = (own, *(solved(f"{size:.3g}h", size, *coarser(mesh, settings, size)) for size in sizes))
    middle = meshes[2]
    far_field: tuple[Run, ...] = ()
    if "half_plane" in (scene.bodies.lower.kind, scene.bodies.upper.kind):
        radius, (cut, law) = mesh.far_radius, coarser(mesh, settings, ratio**2)
        if 4 <= radius <= 500:
            large, small = (
                solved(f"{middle.label}, {words}", size, replace(cut, far_radius=radius / size), law)
                for words, size in (("2 L", 0.5), ("L/2", 2.0))
            )
            far_field = (large, replace(middle, size=1.0), small)
        else:
            missing["far field"] = f"a half-disc of radius {radius:g} a leaves no room for one of half and one of twice"
    step: tuple[Run, ...] | None = None
    if not on_polygon:
        cut, law = coarser(mesh, settings, ratio**2)
        step = middle, solved(f"{middle.label}, halved increments", middle.size, cut, finer_steps(law))
    pairs = []
    if settings.method == "penalty":
        # With the layer and without it, on the run's own mesh and the next: the second shows what the mesh does to the difference.
        # On coarser ones that says nothing: where edges stand in their elements moves W by more than the layer does.
        exact = replace(settings, method="augmented_lagrangian", normal_stiffness=1e3, tangential_stiffness=1e3)
        for run in meshes[:2]:
            cut, _ = coarser(mesh, settings, run.size)
            pairs.append((run, solved(f"{run.label}, law met exactly", run.size, cut, exact)))
    return Refinements(meshes, far_field, tuple(pairs), middle.label, missing, time.process_time() - begun, step)


@dataclass(frozen=True)
class Term:
    """One source of error in one metric."""

    name: str  # "mesh", "step", ...
    value: float | None  # its share of the metric, signed; None where nothing stands out of the scatter, or nothing was measured
    uncertainty: float | None  # of that share; None where nothing was measured
    how: str  # by what it was measured, or why not
    # the uncertainty is one that is never exceeded: bounds add up, the others go by the root of the sum of squares
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
    half_planes: bool  # whether the bodies are the half-planes of theory, so that there is no idealisation, see `are_half_planes`

    @property
    def total(self) -> float:
        """E: what the metric says."""
        return float("nan") if self.metric.value is None else self.metric.value

    @property
    def rest(self) -> float:
        """What no term accounts for: the idealisation error, or of half-planes what is unexplained."""
        return self.total - sum(term.value or 0.0 for term in self.terms)

    @property
    def uncertainty(self) -> float | None:
        """u of the rest; None where a term was not measured."""
        if not all(term.measured for term in self.terms):
            return None
        doubts = [(term.uncertainty or 0.0, term.bound) for term in self.terms]
        return math.hypot(*(u for u, bound in doubts if not bound)) + sum(u for u, bound in doubts if bound)

    @property
    def judged(self) -> Metric:
        """The metric with u for its uncertainty; as it is where u is not known."""
        return self.metric if self.uncertainty is None else replace(self.metric, uncertainty=self.uncertainty)

    @property
    def resolved(self) -> bool | None:
        """Whether an idealisation error stands out, |rest| > u; None where that is not known."""
        return None if self.uncertainty is None or not math.isfinite(self.rest) else abs(self.rest) > self.uncertainty

    @property
    def honest(self) -> bool | None:
        """Whether the stated uncertainty covers the error: known for half-planes only, where the rest must be nothing."""
        return None if not self.half_planes or self.resolved is None else not self.resolved


@dataclass(frozen=True, eq=False)
class ErrorBudget:
    """Budgets of all metrics, the runs they rest on, and CPU seconds of the plain run and of these."""

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
        """What can be said of the stated uncertainties."""
        known = [budget.honest for budget in self.budgets if budget.honest is not None]
        if not known:
            return "not assessed: the true error of real bodies is not known; half-planes show it, where every term was measured"
        return f"{sum(known)} of {len(known)} metrics: the stated uncertainty covers what the measured terms leave unexplained"


def error_budget(comparison: Comparison, refinements: Refinements, plain_seconds: float) -> ErrorBudget:
    """The budgets of every metric of `comparison` that has a finite value."""
    half_planes, solver = are_half_planes(comparison.scene), _solver(comparison)

    def terms(metric: Metric) -> tuple[Term, ...]:
        mesh, penalty, step = (
            _mesh(metric, comparison, refinements),
            _penalty(metric, comparison, refinements),
            _step(metric, refinements),
        )
        return mesh, penalty, step, _far_field(metric, comparison, refinements), solver, _theory(metric, comparison)

    known = (one for one in comparison.metrics if one.key not in _PARTS and one.value is not None and math.isfinite(one.value))
    return ErrorBudget(tuple(Budget(metric, terms(metric), half_planes) for metric in known), refinements, plain_seconds)


def with_budget(comparison: Comparison, budget: ErrorBudget) -> Report:
    """A report of `comparison` with its budget, every metric with the uncertainty that it is judged with."""
    judged = {one.metric.key: one.judged for one in budget.budgets}
    metrics = tuple(judged.get(metric.key, metric) for metric in comparison.metrics)
    return Report(replace(comparison, metrics=metrics), budget)


def _known(metric: Metric, runs: Iterable[Run]) -> list[tuple[float, float]]:
    """Size and value of the runs that have a finite one."""
    found = ((run.size, run.values.get(metric.key)) for run in runs)
    return [(size, value) for size, value in found if value is not None and math.isfinite(value)]


def _not_measured(name: str, runs: Iterable[Run] = (), why: str = "", before: str = "") -> Term:
    """A term that nothing is known of: why, or what the runs failed by."""
    why = why or "; ".join(run.failure for run in runs if run.failure) or "a run has no finite value"
    return Term(name, None, None, f"not measured: {before}{why}")


def _extrapolated(name: str, metric: Metric, refinements: Refinements, runs: tuple[Run, ...], order: float) -> Term:
    """phi - phi_0 of the run itself, which is that of size 1; no value where the values only scatter."""
    known = dict(_known(metric, runs))
    if name in refinements.not_measured or len(known) < 3 or 1.0 not in known:
        return _not_measured(name, runs, refinements.not_measured.get(name, ""))
    found = extrapolate(Refinement(tuple(known), tuple(known.values()), order, ROUNDING))
    value = None if found.kind in ("oscillating", "diverging") else known[1.0] - (found.value or 0.0)
    return Term(name, value, found.uncertainty, found.rule, order=found.order, kind=found.kind)


def _mesh(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """phi(h) - phi(0); no less doubtful than the run itself says."""
    found = _extrapolated("mesh", metric, refinements, refinements.mesh, 2.0)
    if found.uncertainty is None:
        return found
    how = f"{', '.join(run.label for run in refinements.mesh if not run.failure)}: {found.kind}; {found.how}"
    least, result, scales = metric.uncertainty or 0.0, comparison.result, comparison.scales
    stated = getattr(result, f"{metric.key}_uncertainty", None)  # of the edges, at the instant of the metric
    if stated is not None and metric.time is not None:
        least = max(least, float(max(stated[int(abs(result.time - metric.time).argmin())])) / scales.half_width)
    work = result.dissipation_uncertainty / (
        scales.dissipation if metric.absolute else abs(comparison.reference.dissipation) or 1.0
    )
    if metric.key == "dissipation" and work < found.uncertainty:
        # Where edges stand in their elements moves W from mesh to mesh: a few meshes show that scatter, and no order.
        how = f"{how}, {found.uncertainty:.1e}; instead the smaller uncertainty that the run itself states"
        return Term("mesh", None, work, how)
    if found.uncertainty < least < math.inf:
        return replace(found, uncertainty=least, how=f"{how}; uncertainty that the run itself states")
    return replace(found, how=how)


def _step(metric: Metric, refinements: Refinements) -> Term:
    """What the metric loses when theory steps through the same polygon as the result: exact, for every metric.

    Where theory has no answer on it, what halved increments change: 4/3 of that by the second order of increments, as uncertain as
    all of it.
    """
    if refinements.step is not None:
        known = [value for _, value in _known(metric, refinements.step)]
        if len(known) < 2:
            before = "half-plane theory has no answer on the polygon of the steps, and "
            return _not_measured("step", refinements.step, before=before)
        change = known[0] - known[1]
        how = (
            f"halved increments at {refinements.coarse}, second order; half-plane theory has no answer on the polygon of the steps"
        )
        return Term("step", 4 / 3 * change, abs(change) + ROUNDING, how)
    polygon = _known(metric, refinements.mesh[:1])
    if not polygon or metric.value is None:
        return _not_measured("step", why="theory on the polygon of the steps has no such value")
    how = "exact: half-plane theory on the smooth path against itself on the polygon of the steps"
    return Term("step", metric.value - polygon[0][1], ROUNDING, how, bound=True)


def _penalty(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """With the layer less without; uncertain by what one coarser mesh makes of that, twice."""
    if comparison.result.settings.get("solver", {}).get("method") != "penalty":
        return Term("penalty", None, 0.0, "none by construction: the law is met exactly", bound=True)
    pairs = [[value for _, value in _known(metric, pair)] for pair in refinements.penalty]
    shares = [pair[0] - pair[1] for pair in pairs if len(pair) == 2]
    if "penalty" in refinements.not_measured or len(shares) < 2:
        return _not_measured("penalty", chain(*refinements.penalty), refinements.not_measured.get("penalty", ""))
    how = "with the layer less without it, at h; twice what that changes by at the next coarser mesh"
    return Term("penalty", shares[0], 2 * abs(shares[0] - shares[1]), how)


def _far_field(metric: Metric, comparison: Comparison, refinements: Refinements) -> Term:
    """phi(L) - phi(infinity) on the coarse mesh."""
    if "half_plane" not in (comparison.scene.bodies.lower.kind, comparison.scene.bodies.upper.kind):
        return Term("far field", None, 0.0, "none: the bodies have a size of their own", bound=True)
    found = _extrapolated("far field", metric, refinements, refinements.far_field, 4.0)
    if found.uncertainty is None:
        return found
    how = f"radius 2 L, L, L/2 on the mesh of {refinements.coarse}: {found.kind}"
    if found.kind == "exact" or plausible(found.order, 4.0):
        return replace(found, how=how)
    heights = [value for _, value in _known(metric, refinements.far_field)]
    how += "; not resolved: the scatter between meshes is as large"
    return replace(found, value=None, uncertainty=max(heights) - min(heights), how=how)


def _solver(comparison: Comparison) -> Term:
    """The worst residual of any step: dimensionless, a bound for what rounding and termination may do."""
    checks = [check for check in comparison.result_certificates if check.source == "record"]
    if not checks:
        return _not_measured("solver", why="the result states no residuals")
    worst = max(checks, key=lambda check: check.value)
    return Term("solver", None, worst.value, f"worst residual of any step: {worst.name}", bound=True)


def _theory(metric: Metric, comparison: Comparison) -> Term:
    """What the reference states of its own quadratures and series."""
    field = _FIELDS.get(metric.key, metric.key)
    polygon = comparison.polygon_reference
    records = [comparison.reference.record, *([polygon.record] if polygon else [])]
    stated = max((value for record in records for name, value in record.errors.items() if name.startswith(field)), default=None)
    if stated is None:
        return Term("half-plane theory", None, ROUNDING, "closed forms: rounding", bound=True)
    return Term("half-plane theory", None, stated + ROUNDING, "its own estimate of quadratures and series", bound=True)
