"""Does the stated uncertainty of the error budget cover the known error, what does it cost, and which term does a fault fall on?

    python benchmarks/budget.py            (five minutes)

Covered: of half-planes the true error is known, the whole discrepancy; what the measured terms leave unexplained must be covered by
the stated uncertainty at least 95 times of 100, over the metrics of the first table and the half-plane scenes of the library, on a
mesh of twice the default sizes (a/80 at the edges) with the default steps. Metrics that are nothing but round-off error,
|E| < 1e-11, are not counted: they would be covered for free.

Blame: faults are planted in either engine. A metric sees a fault where its value leaves the band of the healthy run, |E| + u.
Blamed is the largest term of the budget of the metric that left it farthest; "model" is what no term accounts for: on half-planes
there must be nothing, so one of the engines is wrong. What the steps do to the dissipation is a metric by itself, and exact.
"""

from __future__ import annotations

import contextlib
import functools
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any
from unittest import mock

import must_fail
import numpy as np
from beside_theory import beside_theory
from claim import Row, slope, table
from real_bodies import blocks, mindlin

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports import Comparison
from reports.comparison.budget import Budget, ErrorBudget, climb, coarser, error_budget, without_steps
from reports.comparison.convergence import Ladder, extrapolate, grid_convergence
from reports.comparison.metrics import are_half_planes
from scenes import ContactSolution, Materials, Scene, load_scene, scene_names

COARSE, MESH, STEPS = MeshSettings(element_size=1 / 12, edge_element_size=1 / 80), MeshSettings(), SolverSettings()


def compared(scene: Scene, mesh: MeshSettings, steps: SolverSettings = STEPS) -> Comparison:
    """The plain run."""
    return beside_theory(halfplane_fe.solve(scene, mesh, steps))


def budget_of(comparison: Comparison, mesh: MeshSettings, steps: SolverSettings, plain: float) -> ErrorBudget:
    """The budget of a run that took `plain` CPU seconds."""
    runs = climb(comparison, mesh, steps, lambda _name: contextlib.nullcontext(lambda *_progress: None))
    return error_budget(comparison, runs, plain)


def budgeted(scene: Scene, mesh: MeshSettings = COARSE) -> ErrorBudget:
    """The plain run and its budget."""
    begun = time.process_time()
    comparison = compared(scene, mesh)
    return budget_of(comparison, mesh, STEPS, time.process_time() - begun)


@functools.cache
def library() -> dict[str, ErrorBudget]:
    """Budgets of all half-plane scenes of the library."""
    scenes = {name: load_scene(name) for name in scene_names()}
    return {name: budgeted(scene) for name, scene in scenes.items() if are_half_planes(scene)}


def published() -> Iterator[Row]:
    """NPARC Alliance, Examining Spatial (Grid) Convergence: values, ratio 2, safety factor 1.25."""
    nasa = Ladder((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178))
    found, index = extrapolate(nasa), grid_convergence(nasa)
    for what, value, right in (
        ("order", found.order, 1.786170),
        ("extrapolated value", found.value, 0.971300),
        ("GCI of the finer two", index.fine, 0.001031),
        ("GCI of the coarser two", index.coarse, 0.003562),
        ("asymptotic ratio", index.ratio, 0.997980),
    ):
        yield Row(f"NASA's example, {what}: digits off", round(value, 6) - right, 1e-9, f"{value:.8f}, published {right}")


def coverage() -> Iterator[Row]:
    """How often the stated uncertainty covers the known error, by metric and over all."""
    budgets = [(name, one) for name, found in library().items() for one in found.budgets]
    pairs = [(name, one) for name, one in budgets if one.metric.definition.headline and abs(one.total) > 1e-11]
    known = [(name, one) for name, one in pairs if one.honest is not None]
    what = "budget: metrics that have no uncertainty, a term not being measured"
    yield Row(what, len(pairs) - len(known), None, "left out below")
    missed = [f"{name} {one.metric.key}" for name, one in known if not one.honest]
    how = f"{len(known) - len(missed)} of {len(known)} covered over {len(library())} scenes; not: {', '.join(missed) or 'none'}"
    yield Row("budget: share not covered by the stated uncertainty", len(missed) / len(known), 0.05, how)
    thin = sum(abs(one.rest) > (one.uncertainty or 0.0) / 10 for _, one in known) / len(known)
    yield Row("budget: ... by a tenth of it", thin, None, "the count can fail: no uncertainty is a blank cheque")

    def sharpness(ones: list[Budget]) -> float:
        return float(np.median([(one.uncertainty or 0.0) / abs(one.total) for one in ones]))

    yield Row("budget: u over |E|, median", sharpness([one for _, one in known]), None, "sharpness")
    for key in dict.fromkeys(one.metric.key for _, one in known):
        mine = [one for _, one in known if one.metric.key == key]
        how = f"{sum(bool(one.honest) for one in mine)} of {len(mine)}; u/|E| {sharpness(mine):.2g} in the median"
        yield Row(f"budget: {key} not covered", sum(not one.honest for one in mine) / len(mine), None, how)


def cost() -> Iterator[Row]:
    """CPU time of run and budget over that of the run; the far-field runs stand on 4 h: doubling L there and on the run's mesh."""
    ratios = {name: found.cost for name, found in library().items()}
    worst = max(ratios, key=ratios.__getitem__)
    yield Row("budget, twice the default sizes: cost over the plain run, worst scene", ratios[worst], None, worst)
    for name in ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper"):
        found = budgeted(load_scene(name), MESH)
        yield Row(f"budget of {name}: cost over the plain run", found.cost, 4.0, "default mesh; nothing read from the store")
    for label, factor in (("h", 1.0), ("4h", 4.0)):
        cut, _ = coarser(COARSE, STEPS, factor)
        paper = load_scene("hertz-paper")
        near, far = (without_steps(compared(paper, replace(cut, far_radius=radius))) for radius in (10.0, 20.0))
        for key in ("dissipation", "peak_pressure"):
            what = f"far field on {label}: {key} at L = 10 a less at 20 a"
            yield Row(what, (near[key] or 0.0) - (far[key] or 0.0), None, "hertz-paper, scatter of meshing anew included")


def real() -> Iterator[Row]:
    """Square blocks that grow: the idealisation error, with its u, goes as (a/size)^2. Real bodies have no known answer: the
    idealisation error +- u of the budget against the discrepancy on half the sizes.
    """
    sizes = (4.0, 8.0, 16.0)
    found = [budgeted(mindlin(blocks(size))) for size in sizes]
    for key in ("dissipation", "peak_pressure"):
        rungs = [one.budget(key) for one in found]
        how = "; ".join(
            f"{size:g} a: {one.rest:+.2e} ± {one.uncertainty or float('nan'):.0e} {'' if one.resolved else 'not '}resolved"
            for size, one in zip(sizes, rungs, strict=True)
        )
        order = -slope(sizes, [one.rest for one in rungs])
        yield Row(f"blocks, idealisation error of {key}: order in a/size, less 2", order - 2, 0.3, how)
    covered, missed = 0, []
    for name, scene in ((name, load_scene(name)) for name in scene_names()):
        if scene.bodies.half_planes:
            continue
        fine = without_steps(compared(scene, MESH))
        for one in budgeted(scene).budgets:
            truth = fine.get(one.metric.key)
            if one.metric.definition.headline and abs(one.total) > 1e-11 and truth is not None and one.uncertainty is not None:
                inside = abs(one.rest - truth) <= one.uncertainty
                covered, missed = covered + inside, missed + ([] if inside else [f"{name} {one.metric.key}"])
    how = f"the discrepancy on half the sizes within u: {covered} of {covered + len(missed)}; not: {', '.join(missed) or 'none'}"
    yield Row("budget, real bodies: share not covered", len(missed) / (covered + len(missed)), 0.05, how)


def rows() -> Iterator[Row]:
    """The claims of the budget; half of the time is the library's."""
    for part in (published, coverage, cost, real):
        yield from part()


# -------------------------------------------------------------------------------------------------------------------- blame
SOLVE = import_module("halfplane_fe.solve")
THEORY = semi_analytic.solve
Planted = contextlib.AbstractContextManager[Any]

STEP = "dissipation_step"
# Where the worst of single instants, or one of few, is too much a matter of chance to blame anything by.
LEFT_OUT = ("stick_edge", "state", "full_stick", "slip_reversal", "place", "resultant", "energy", "tangential_displacement")


@dataclass(frozen=True)
class Fault:
    """What is planted, how, and the term that shall be blamed."""

    name: str
    blamed: str
    plant: Callable[[], Planted] = contextlib.nullcontext
    mesh: MeshSettings = MESH
    settings: dict[str, Any] = field(default_factory=dict)


def theory(change: Callable[[Scene], Scene]) -> Planted:
    """Half-plane theory answers another question, and says that it was the one asked."""

    def planted(scene: Scene, *given: Any, **named: Any) -> ContactSolution:
        return replace(THEORY(change(scene), *given, **named), scene=scene)

    return mock.patch.object(semi_analytic, "solve", planted)


def rubbing(factor: float) -> Callable[[Scene], Scene]:
    """Another coefficient of friction."""
    return lambda scene: scene.vary(friction=factor * scene.friction.coefficient)


def other_nu(scene: Scene) -> Scene:
    """Poisson's ratio of the upper body 0.4."""
    upper = scene.material.upper.vary(poisson_ratio=0.4)
    return scene.vary(material=Materials(upper=upper, lower=scene.material.lower))


def other_body() -> Planted:
    """The FE model condenses an upper body of another Poisson's ratio."""
    make = SOLVE.condensed_pair
    return mock.patch.object(SOLVE, "condensed_pair", lambda scene, *given: make(other_nu(scene), *given))


def turned() -> Planted:
    """Half-plane theory gives q and U the wrong sign."""

    def planted(*given: Any, **named: Any) -> ContactSolution:
        found = THEORY(*given, **named)
        return replace(found, shear=-found.shear, tangential_displacement=-found.tangential_displacement, slip=-found.slip)

    return mock.patch.object(semi_analytic, "solve", planted)


FAULTS = (
    Fault("FE: friction 1 % low", "model", lambda: must_fail.friction(0.99)),
    Fault("FE: history dropped", "model", lambda: must_fail.equilibrium(must_fail.forgetting)),
    # Friction then works the wrong way round: the residuals of the laws say so.
    Fault("FE: sign of Q flipped", "solver", lambda: must_fail.equilibrium(must_fail.turned_round)),
    Fault("FE: nu of the upper body 0.4 for 0.3", "model", other_body),
    Fault("FE: mesh mis-graded, a/10 where edges travel", "mesh", mesh=MeshSettings(element_size=1 / 10, edge_element_size=1 / 10)),
    Fault(
        "FE: gap off by h/10 at mid-side nodes, by 4 h/10 on twice the size",
        "mesh",
        lambda: must_fail.gap(lambda problem: must_fail.rough(problem, MESH.edge_element_size)),
    ),
    Fault(
        "FE: penalty too soft, 3 E*/h",
        "penalty",
        settings={"method": "penalty", "normal_stiffness": 3.0, "tangential_stiffness": 3.0},
    ),
    # With events landed on, four increments a revolution leave every metric in its band: friction work follows the curve.
    Fault(
        "FE: steps too long, 4 a revolution, no event landed on",
        "step",
        must_fail.blind,
        settings={"steps_per_cycle": 4, "step_tolerance": float("inf")},
    ),
    Fault("theory: friction 1 % high", "model", lambda: theory(rubbing(1.01))),
    Fault("theory: signs of q, U and s flipped", "model", turned),
    Fault("theory: nu of the upper body 0.4 for 0.3", "model", lambda: theory(other_nu)),
)


@dataclass(frozen=True)
class Found:
    """Values of the metrics, and budgets of all but the step's own."""

    values: dict[str, float]
    budgets: dict[str, Budget]

    def band(self, key: str) -> float:
        """|E| + u."""
        doubt = self.budgets[key].uncertainty if key in self.budgets else None
        return abs(self.values[key]) + (abs(self.values[key]) if doubt is None else doubt)

    def blamed(self, key: str) -> str:
        """The term that has the largest share of a metric, or may have; the model only where it stands out of its uncertainty."""
        if key == STEP:
            return "step"
        one = self.budgets[key]
        parts = {term.name: max(abs(term.value or 0.0), term.uncertainty or 0.0) for term in one.terms}
        parts["model"] = abs(one.rest) if one.resolved else 0.0
        return max(parts, key=parts.__getitem__)


def seen(faulty: Found, healthy: Found) -> dict[str, float]:
    """How many healthy bands wide each metric is that has left its own, the widest first."""
    wide = {key: abs(value) / healthy.band(key) for key, value in faulty.values.items() if healthy.values.get(key)}
    return dict(sorted(((key, ratio) for key, ratio in wide.items() if ratio > 1), key=lambda item: -item[1]))


def solved(fault: Fault) -> Found:
    """Metrics and budgets of a run of the paper's cycle with a fault in it."""
    settings = replace(STEPS, **fault.settings)
    with fault.plant():
        comparison = compared(load_scene("hertz-paper"), fault.mesh, settings)
        budgets = budget_of(comparison, fault.mesh, settings, 1.0).budgets
    kept = {one.metric.key: one for one in budgets if not any(part in one.metric.key for part in LEFT_OUT)}
    return Found({key: one.total for key, one in kept.items()} | {STEP: comparison.metric(STEP).value or 0.0}, kept)


def blame() -> Iterator[Row]:
    """A row for each fault: 0 where it was seen and the right term blamed, else 1."""
    healthy = solved(Fault("none", ""))
    yield Row("healthy: metrics that leave their own band", len(seen(healthy, healthy)), 0.0, f"{len(healthy.values)} metrics")
    for fault in FAULTS:
        faulty = solved(fault)
        caught = seen(faulty, healthy)
        blamed = faulty.blamed(next(iter(caught))) if caught else "nobody"
        how = f"seen by {', '.join(f'{key} ({ratio:.3g} bands)' for key, ratio in list(caught.items())[:3])}; blamed: {blamed}"
        yield Row(fault.name, float(blamed != fault.blamed), 0.0, how)


if __name__ == "__main__":
    print(table([*rows(), *blame()]))
