"""What `reports.score` says a wrong result suffers from, on results that suffer from just that.

    python benchmarks/diagnosis.py            (some minutes; with names of faults: those alone)

Every fault is planted from strong to mild in three scenes: in a file by altering its arrays, in a question by solving another one,
in a model by running the finite elements with it. The first diagnosis is compared with what was planted. A fault so mild that the
result stays within the scene's tolerances is not seen, and shall not be.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import must_fail
import numpy as np
from beside_theory import beside_theory
from claim import Row

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports import compare
from reports.comparison import Comparison
from reports.scoring.diagnosis import UNKNOWN, diagnose
from reports.scoring.diagnosis_theory import stiffer, with_friction
from scenes import Bodies, ContactSolution, EllipseLoad, Materials, Scene, load_scene

SCENES = ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper")
# The default mesh, on which a healthy run is within tolerance: the fault is planted alone, with no coarseness beside it.
MESH = MeshSettings()
FOREVER = float("inf")
INSTANTS, POINTS = 60, 121
NOTHING = "nothing"


@dataclass(frozen=True)
class Fault:
    """What is planted, from strong to mild, and how: scene and severity to a comparison."""

    key: str
    severities: tuple[float, ...]
    plant: Callable[[Scene, float], Comparison]
    unit: str = ""


# ------------------------------------------------------------------------------------------------------- results that are altered
def times(scene: Scene, a_cycle: int = INSTANTS) -> np.ndarray:
    """The initial loading and four revolutions."""
    path = scene.load.path()
    revolutions = path.cycle_start + 4 * (path.period or 0.0) * np.linspace(0, 1, 4 * a_cycle + 1)
    return np.concatenate([np.linspace(path.start, path.cycle_start, 5)[:-1], revolutions])


@cache
def truth(name: str) -> ContactSolution:
    """Half-plane theory as another code would give it: equal spacings in x and time."""
    scene = load_scene(name)
    half = float(semi_analytic.solve(scene).contact_half_width.max())
    return semi_analytic.solve(scene, x=np.linspace(-1.3 * half, 1.3 * half, POINTS), time=times(scene))


def altered(change: Callable[[ContactSolution, float], ContactSolution]) -> Callable[[Scene, float], Comparison]:
    """A result that is the truth, but for that."""
    return lambda scene, severity: compare(truth(scene.name), change(truth(scene.name), severity))


def asked(change: Callable[[Scene, float], Scene]) -> Callable[[Scene, float], Comparison]:
    """A result that is the truth of another scene."""

    def plant(scene: Scene, severity: float) -> Comparison:
        true = truth(scene.name)
        return compare(true, replace(semi_analytic.solve(change(scene, severity), x=true.x, time=true.time), scene=scene))

    return plant


def scaled(true: ContactSolution, factor: float) -> ContactSolution:
    return replace(true, pressure=factor * true.pressure, shear=factor * true.shear)


def loaded(scene: Scene, factor: float) -> Comparison:
    """Loads times a factor: by linearity the tractions of bodies that much more compliant, times the factor."""
    comparison = asked(stiffer)(scene, 1 / factor)
    return compare(truth(scene.name), scaled(comparison.result, factor))


def moved(true: ContactSolution, distance: float) -> ContactSolution:
    """The centre off by so much of the largest half-width."""
    other = semi_analytic.solve(true.scene, x=true.x - distance * float(true.contact_half_width.max()), time=true.time)
    return replace(true, pressure=other.pressure, shear=other.shear)


def late(true: ContactSolution, delay: float) -> ContactSolution:
    """So much of a period late, in the last revolution."""
    period, rows = true.scene.load.path().period or 0.0, true.last_cycle
    other = semi_analytic.solve(true.scene, x=true.x, time=true.time[rows] - delay * period)
    return last(true, other, np.arange(len(rows)))


def last(true: ContactSolution, other: ContactSolution, rows: np.ndarray) -> ContactSolution:
    """The last revolution's tractions replaced by those of `other`."""
    pressure, shear = true.pressure.copy(), true.shear.copy()
    pressure[true.last_cycle], shear[true.last_cycle] = other.pressure[rows], other.shear[rows]
    return replace(true, pressure=pressure, shear=shear)


def first_revolution(true: ContactSolution, _severity: float) -> ContactSolution:
    return last(true, true, np.arange(4, 4 + INSTANTS + 1))


# ------------------------------------------------------------------------------------------------------- finite elements at fault
def solved(scene: Scene, mesh: MeshSettings = MESH, **settings: Any) -> Comparison:
    """Finite elements against half-plane theory at the same points and instants."""
    return beside_theory(halfplane_fe.solve(scene, mesh, SolverSettings(**settings)))


def few_steps(scene: Scene, steps: float) -> Comparison:
    """Increments that land on no event. On a polygon, whose corners they can't miss, theory on straight lines that do."""
    if isinstance(scene.load, EllipseLoad):
        with must_fail.blind():
            return solved(scene, steps_per_cycle=int(steps), step_tolerance=FOREVER)
    x, time = truth(scene.name).x, times(scene, int(steps) + 1)
    reference, polygon = (semi_analytic.solve(scene, x=x, time=time, straight_steps=straight) for straight in (False, True))
    return compare(reference, replace(polygon, scene=scene), polygon_reference=polygon)


def blocks(scene: Scene, height: float) -> Comparison:
    """Two blocks, twice as wide as high, in place of half-planes."""
    block = {"kind": "block", "width": 2 * height, "height": height}
    bodies = Bodies.model_validate({"lower": block, "upper": block})
    return solved(scene.vary(bodies=bodies))


def unlike(scene: Scene, poisson_ratio: float) -> Comparison:
    """The upper body with another nu."""
    upper = scene.material.upper.vary(poisson_ratio=poisson_ratio)
    return solved(scene.vary(material=Materials(upper=upper, lower=scene.material.lower)))


def forgetful(scene: Scene, _severity: float) -> Comparison:
    """Each increment starts from faces that have never slipped; few of them, for they never settle."""
    with must_fail.equilibrium(must_fail.forgetting):
        return solved(scene, steps_per_cycle=32, step_tolerance=FOREVER)


def soft(name: str) -> Callable[[Scene, float], Comparison]:
    """A penalty of so many E*/a, the other one stiff; the solver's own unit is E*/h, h being that of the edges."""
    stiff: dict[str, Any] = {"normal_stiffness": 1e4, "tangential_stiffness": 1e4}
    return lambda scene, severity: solved(scene, method="penalty", **(stiff | {name: severity * MESH.edge_element_size}))


FAULTS = (
    Fault("shear_sign", (1.0,), altered(lambda true, _: replace(true, shear=-true.shear))),
    Fault("pressure_sign", (1.0,), altered(lambda true, _: replace(true, pressure=-true.pressure))),
    Fault("swapped", (1.0,), altered(lambda true, _: replace(true, pressure=true.shear, shear=true.pressure))),
    Fault("frictionless", (1.0,), altered(lambda true, _: replace(true, shear=np.zeros_like(true.shear)))),
    Fault("units", (1e6, 1e-3, 10.0), altered(scaled), "times"),
    Fault("traction_factor", (1.5, 1.1, 1.02), altered(scaled), "times"),
    Fault("pressure_factor", (1.5, 1.1, 1.01), altered(lambda true, k: replace(true, pressure=k * true.pressure)), "times"),
    Fault("offset", (0.3, 0.03, 0.01, 0.001), altered(moved), "a"),
    Fault("stiffness", (2.0, 0.91, 0.97, 0.99, 0.998), asked(stiffer), "E*/R"),
    Fault("half_model", (0.5, 2.0), loaded, "P"),
    Fault("loads", (1.3, 1.05, 1.01, 1.002), loaded, "P"),
    Fault("friction", (1.5, 1.1, 0.97, 1.01), asked(lambda scene, k: with_friction(scene, k * scene.friction.coefficient)), "f"),
    Fault("full_stick", (50.0,), asked(lambda scene, k: with_friction(scene, k * scene.friction.coefficient)), "f"),
    Fault("memoryless", (1.0,), forgetful),
    Fault("not_steady", (1.0,), altered(first_revolution)),
    Fault("other_times", (0.25, 0.05, 0.01, 0.002), altered(late), "periods"),
    Fault("steps", (4.0, 8.0, 12.0, 24.0, 48.0), few_steps, "a cycle"),
    Fault("elastic_slip", (2.4, 7.2, 24.0, 72.0, 240.0), soft("tangential_stiffness"), "E*/a"),
    Fault("soft_normal", (12.0, 24.0, 72.0, 240.0), soft("normal_stiffness"), "E*/a"),
    Fault("small_body", (2.5, 4.0, 8.0, 16.0), blocks, "a high"),
    Fault("coupling", (0.45, 0.4, 0.35), unlike, "nu for 0.3"),
    Fault(
        "coarse_edge",
        (1 / 5, 1 / 8, 1 / 12, 1 / 24),
        lambda scene, size: solved(scene, MeshSettings(element_size=size, edge_element_size=size)),
        "a",
    ),
)


@dataclass(frozen=True)
class Guess:
    """What was planted and what came first; "nothing" for a result within tolerance."""

    scene: str
    fault: Fault
    severity: float
    first: str
    strength: float

    @property
    def right(self) -> bool:
        return self.first == self.fault.key


def guesses(fault: Fault, scenes: tuple[str, ...] = SCENES) -> Iterator[Guess]:
    """Every severity in every scene."""
    for name in scenes:
        for severity in fault.severities:
            found = diagnose(fault.plant(load_scene(name), severity))
            yield Guess(name, fault, severity, found[0].fault if found else NOTHING, found[0].strength if found else 0.0)


def row(fault: Fault, made: list[Guess]) -> Row:
    """One line of the confusion table: how many of the results out of tolerance were told wrong."""
    seen = [one for one in made if one.first != NOTHING]
    named = ", ".join(f"{key} {count}" for key, count in Counter(one.first for one in made).most_common())
    mildest = [
        f"{name}: {max(right, key=fault.severities.index):g}"
        for name in SCENES
        if (right := [one.severity for one in seen if one.scene == name and one.right])
    ]
    until = f"; mildest seen and named ({fault.unit}): {', '.join(mildest)}" if fault.unit else ""
    wrong = "; ".join(f"{one.scene} at {one.severity:g}: {one.first}" for one in seen if not one.right)
    how = f"planted {len(made)}, said first: {named}{until}" + (f"; told wrong: {wrong}" if wrong else "")
    return Row(f"{fault.key}: first diagnosis wrong", sum(not one.right for one in seen), None, how, "results")


def clean(name: str) -> tuple[str, ...]:
    """What is said of a right result: the truth on other points, and finite elements on their default mesh."""
    found = [compare(truth(name), truth(name)), solved(load_scene(name), MeshSettings())]
    return tuple(one.fault for comparison in found for one in diagnose(comparison))


def rows(keys: tuple[str, ...] = ()) -> Iterator[Row]:
    """The confusion table, a row for each fault; then the share of wrong first guesses, and what is said of right results."""
    os.environ["HALFPLANE_CACHE"] = "off"
    every: list[Guess] = []
    for fault in FAULTS:
        if not keys or fault.key in keys:
            made = list(guesses(fault))
            every += made
            yield row(fault, made)
    seen = [one for one in every if one.first != NOTHING]
    wrong, unknown = [one for one in seen if not one.right], sum(one.first == UNKNOWN for one in seen)
    how = f"{len(seen)} results out of tolerance, {len(every)} planted; {unknown} of the wrong ones said to fit no known pattern"
    yield Row("first diagnosis wrong, all faults, scenes and severities", len(wrong) / len(seen), 0.05, how)
    strong = [one for one in every if one.severity == one.fault.severities[0]]
    yield Row("first diagnosis wrong, strongest of each fault", sum(not one.right for one in strong), 0, f"{len(strong)} results")
    if not keys:
        said = [fault for name in SCENES for fault in clean(name)]
        yield Row("faults found in right results", len(said), 0, f"theory and default finite elements, {', '.join(SCENES)}")


def main() -> None:
    for one in rows(tuple(sys.argv[1:])):
        print(f"{'MISSED ' if one.kept is False else ''}{one.what}: {one.measured:.3g}; {one.how}", flush=True)


if __name__ == "__main__":
    main()
