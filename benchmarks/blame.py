"""Faults planted in either engine: which metric sees each, and which term of the error budget is blamed.

    python benchmarks/blame.py            (about a minute)

A metric sees a fault where its value leaves the band of the healthy run, |E| + u. Blamed is the largest term of the budget of the
metric that left it farthest; "model" is what no term accounts for: on half-planes there must be nothing, so one of the engines is
wrong. What the steps do to the dissipation is a metric by itself, and exact.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any
from unittest import mock

import must_fail
from beside_theory import beside_theory
from claim import Row

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.comparison.budget import Budget, climb, error_budget
from scenes import ContactSolution, Materials, Scene, load_scene

SOLVE = import_module("halfplane_fe.solve")
THEORY = semi_analytic.solve
Planted = contextlib.AbstractContextManager[Any]

MESH, SETTINGS = MeshSettings(), SolverSettings()
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
    Fault("FE: gap off by h/10 at mid-side nodes", "mesh", lambda: must_fail.gap(must_fail.rough)),
    Fault(
        "FE: penalty too soft, 3 E*/h",
        "penalty",
        settings={"method": "penalty", "normal_stiffness": 3.0, "tangential_stiffness": 3.0},
    ),
    Fault("FE: steps too long, 4 a revolution", "step", settings={"steps_per_cycle": 4, "step_tolerance": float("inf")}),
    Fault("theory: friction 1 % high", "model", lambda: theory(rubbing(1.01))),
    Fault("theory: signs of q, U and s flipped", "model", turned),
    Fault("theory: nu of the upper body 0.4 for 0.3", "model", lambda: theory(other_nu)),
)


def solved(fault: Fault) -> Found:
    """Metrics and budgets of a run of the paper's cycle with a fault in it."""
    scene, settings = load_scene("hertz-paper"), replace(SETTINGS, **fault.settings)
    with fault.plant():
        comparison = beside_theory(halfplane_fe.solve(scene, fault.mesh, settings))
        ladders = climb(comparison, fault.mesh, settings, lambda _name: contextlib.nullcontext(lambda *_progress: None))
        found = error_budget(comparison, ladders, 1.0)
    step = comparison.metric(STEP).value or 0.0
    kept = {one.metric.key: one for one in found.budgets if not any(part in one.metric.key for part in LEFT_OUT)}
    return Found({key: one.total for key, one in kept.items()} | {STEP: step}, kept)


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


def rows() -> Iterator[Row]:
    """A row for each fault: 0 where it was seen and the right term blamed, else 1."""
    os.environ["HALFPLANE_CACHE"] = "off"
    healthy = solved(Fault("none", ""))
    yield Row("healthy: metrics that leave their own band", len(seen(healthy, healthy)), 0.0, f"{len(healthy.values)} metrics")
    for fault in FAULTS:
        faulty = solved(fault)
        caught = seen(faulty, healthy)
        blamed = faulty.blamed(next(iter(caught))) if caught else "nobody"
        how = f"seen by {', '.join(f'{key} ({ratio:.3g} bands)' for key, ratio in list(caught.items())[:3])}; blamed: {blamed}"
        yield Row(fault.name, float(blamed != fault.blamed), 0.0, how)


def main() -> None:
    for row in rows():
        print(f"{'MISSED ' if row.kept is False else ''}{row.what}: {row.how}", flush=True)


if __name__ == "__main__":
    main()
