"""Is the error budget honest, what does it cost, and does the idealisation error vanish as it must?

    python benchmarks/budget.py

Honest: of half-planes the true error is known, the whole discrepancy; what the measured terms leave unexplained must be covered by
the stated uncertainty at least 95 times of 100, over the metrics of the first table and the half-plane scenes of the library, on a
mesh of twice the default sizes (a/80 at the edges) with the default steps; costs also on the default mesh. Metrics that are nothing
but rounding, |E| < 1e-11, are not counted: they would be covered for free. Three minutes.
"""

from __future__ import annotations

import functools
import os
import sys
import time
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from beside_theory import beside_theory
from claim import Row, table

import halfplane_fe
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.comparison.budget import Budget, ErrorBudget, climb, coarser, error_budget, without_steps
from reports.comparison.convergence import Ladder, extrapolate, grid_convergence
from reports.comparison.metrics import are_half_planes
from scenes import Scene, load_scene, scene_names

sys.path.insert(0, str(Path(__file__).parent))
from real_bodies import blocks, mindlin

COARSE = MeshSettings(element_size=1 / 12, edge_element_size=1 / 80)
STEPS = SolverSettings()


@contextmanager
def silent(_name: str) -> Generator:
    """A stage that nobody watches."""
    yield lambda _done, _total, _text: None


def compared(scene: Scene, mesh: MeshSettings):
    """The plain run."""
    return beside_theory(halfplane_fe.solve(scene, mesh, STEPS))


def budgeted(scene: Scene, mesh: MeshSettings = COARSE) -> ErrorBudget:
    """The plain run and its budget."""
    begun = time.process_time()
    comparison = compared(scene, mesh)
    plain = time.process_time() - begun
    return error_budget(comparison, climb(comparison, mesh, STEPS, silent), plain)


@functools.cache
def library() -> dict[str, ErrorBudget]:
    """Budgets of all half-plane scenes of the library."""
    scenes = {name: load_scene(name) for name in scene_names()}
    return {name: budgeted(scene) for name, scene in scenes.items() if are_half_planes(scene)}


def counted() -> list[tuple[str, Budget]]:
    """What the count of coverage is over."""
    return [
        (name, one)
        for name, found in library().items()
        for one in found.budgets
        if one.metric.definition.headline and abs(one.total) > 1e-11
    ]


def published() -> Iterator[Row]:
    """NPARC Alliance, Examining Spatial (Grid) Convergence: values, ratio 2, safety factor 1.25."""
    nasa = Ladder((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178))
    found, index = extrapolate(nasa), grid_convergence(nasa)
    for what, value, right, digits in (
        ("order", found.order, 1.786170, 6),
        ("extrapolated value", found.value, 0.971300, 6),
        ("GCI of the finer two", index.fine, 0.001031, 6),
        ("GCI of the coarser two", index.coarse, 0.003562, 6),
        ("asymptotic ratio", index.ratio, 0.997980, 6),
    ):
        yield Row(f"NASA's example, {what}: digits off", round(value, digits) - right, 1e-9, f"{value:.8f}, published {right}")


def coverage() -> Iterator[Row]:
    """How often the stated uncertainty covers the known error, by metric and over all."""
    pairs = counted()
    known = [(name, one) for name, one in pairs if one.honest is not None]
    yield Row(
        "budget: metrics that have no uncertainty, a term not being measured", len(pairs) - len(known), None, "left out below"
    )
    missed = [f"{name} {one.metric.key}" for name, one in known if not one.honest]
    how = f"{len(known) - len(missed)} of {len(known)} covered over {len(library())} scenes; not: {', '.join(missed) or 'none'}"
    yield Row("budget: share not covered by the stated uncertainty", len(missed) / len(known), 0.05, how)
    thin = sum(abs(one.rest) > (one.uncertainty or 0.0) / 10 for _, one in known) / len(known)
    yield Row("budget: ... by a tenth of it", thin, None, "the count can fail: no uncertainty is a blank cheque")
    yield Row(
        "budget: u over |E|, median", float(np.median([(o.uncertainty or 0) / abs(o.total) for _, o in known])), None, "sharpness"
    )
    for key in dict.fromkeys(one.metric.key for _, one in known):
        mine = [one for _, one in known if one.metric.key == key]
        how = f"{sum(bool(one.honest) for one in mine)} of {len(mine)}; u/|E| {_sharpness(mine):.2g} in the median"
        yield Row(f"budget: {key} not covered", sum(not one.honest for one in mine) / len(mine), None, how)


def _sharpness(budgets: list[Budget]) -> float:
    return float(np.median([(one.uncertainty or 0.0) / abs(one.total) for one in budgets]))


def cost() -> Iterator[Row]:
    """CPU time of run and budget over that of the run."""
    ratios = {name: found.cost for name, found in library().items()}
    worst = max(ratios, key=lambda name: ratios[name])
    yield Row("budget, twice the default sizes: cost over the plain run, worst scene", ratios[worst], None, worst)
    for name in ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper"):
        found = budgeted(load_scene(name), MeshSettings())
        how = "default mesh; nothing read from the store"
        yield Row(f"budget of {name}: cost over the plain run", found.cost, 4.0, how)


def transfer() -> Iterator[Row]:
    """The far-field ladder stands on 4 h: what doubling L does there and on the run's own mesh."""
    scene, mesh = load_scene("hertz-paper"), COARSE
    for label, factor in (("h", 1.0), ("4h", 4.0)):
        cut, _ = coarser(mesh, STEPS, factor)
        near, far = (without_steps(compared(scene, replace(cut, far_radius=radius))) for radius in (10.0, 20.0))
        for key in ("dissipation", "peak_pressure"):
            what = f"far field on {label}: {key} at L = 10 a less at 20 a"
            yield Row(what, (near[key] or 0.0) - (far[key] or 0.0), None, "hertz-paper, scatter of meshing anew included")


def limit() -> Iterator[Row]:
    """Square blocks that grow: the idealisation error, with its u, goes as (a/size)^2."""
    sizes = (4.0, 8.0, 16.0)
    found = [budgeted(mindlin(blocks(size))) for size in sizes]
    for key in ("dissipation", "peak_pressure"):
        rungs = [one.budget(key) for one in found]
        order = -float(np.polyfit(np.log(sizes), np.log([abs(one.rest) for one in rungs]), 1)[0])
        how = "; ".join(
            f"{size:g} a: {one.rest:+.2e} ± {one.uncertainty or float('nan'):.0e} {'' if one.resolved else 'not '}resolved"
            for size, one in zip(sizes, rungs, strict=True)
        )
        yield Row(f"blocks, idealisation error of {key}: order in a/size, less 2", order - 2, 0.3, how)


def finer() -> Iterator[Row]:
    """Real bodies have no known answer: the idealisation error +- u of the budget against the discrepancy on half the sizes."""
    scenes = {name: load_scene(name) for name in scene_names()}
    covered, missed = 0, []
    for name, scene in scenes.items():
        if scene.bodies.half_planes:
            continue
        fine = without_steps(compared(scene, MeshSettings()))
        for one in budgeted(scene).budgets:
            truth = fine.get(one.metric.key)
            if not one.metric.definition.headline or abs(one.total) <= 1e-11 or truth is None or one.uncertainty is None:
                continue
            if abs(one.rest - truth) <= one.uncertainty:
                covered += 1
            else:
                missed.append(f"{name} {one.metric.key}")
    how = f"the discrepancy on half the sizes within u: {covered} of {covered + len(missed)}; not: {', '.join(missed) or 'none'}"
    yield Row("budget, real bodies: share not covered", len(missed) / (covered + len(missed)), 0.05, how)


def rows() -> Iterator[Row]:
    """Everything; half of it the library."""
    kept = os.environ.get("HALFPLANE_CACHE")
    os.environ["HALFPLANE_CACHE"] = "off"  # costs are of runs that condense their bodies themselves
    try:
        for part in (published, coverage, cost, transfer, limit, finer):
            yield from part()
    finally:
        if kept is None:
            del os.environ["HALFPLANE_CACHE"]
        else:
            os.environ["HALFPLANE_CACHE"] = kept


if __name__ == "__main__":
    print(table(list(rows())))
