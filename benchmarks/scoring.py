"""What `halfplane score` gets wrong: its rules on right results, its diagnoses of results with a planted fault, the examples.

A fault is planted in a file by altering its arrays, in a question by solving another one, in a model by running the finite elements
with it. One so mild that the result stays within the scene's tolerances is not seen, and shall not be.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import must_fail
import numpy as np
from claim import ROOT, Row
from finite_elements import beside_theory

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports import Comparison, compare, score
from reports.comparison.metrics import scales
from reports.field_output.files import instants_of, write_fields
from reports.scoring.diagnosis import diagnose, stiffer, with_friction
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read
from reports.scoring.solution import UNTOLD, friction_work, zones
from reports.scoring.surface import TOUCHES
from scenes import Bodies, ContactSolution, EllipseLoad, Materials, Scene, load_scene

SCENES = ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper")
# The default mesh, on which a healthy run is within tolerance: the fault is planted alone, with no coarseness beside it.
MESH = MeshSettings()
INSTANTS, POINTS = 60, 121
DECK_LOAD = 400.0  # P of the decks of tests/data [force / thickness]
Plant = Callable[[Scene, float], Comparison]


# --------------------------------------------------------------------------------------------------- results with a planted fault
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


def altered(**change: Callable[[ContactSolution, float], np.ndarray]) -> Plant:
    """The truth, but for some of its arrays."""

    def plant(scene: Scene, severity: float) -> Comparison:
        true = truth(scene.name)
        arrays: dict[str, Any] = {name: of(true, severity) for name, of in change.items()}
        return compare(true, replace(true, **arrays))

    return plant


def asked(change: Callable[[Scene, float], Scene], factor: Callable[[float], float] = lambda _: 1.0) -> Plant:
    """The truth of another scene, its tractions times a factor."""

    def plant(scene: Scene, severity: float) -> Comparison:
        true = truth(scene.name)
        other = semi_analytic.solve(change(scene, severity), x=true.x, time=true.time)
        k = factor(severity)
        return compare(true, replace(other, scene=scene, pressure=k * other.pressure, shear=k * other.shear))

    return plant


def moved(scene: Scene, distance: float) -> Comparison:
    """The centre off by so much of the largest half-width."""
    true = truth(scene.name)
    other = semi_analytic.solve(scene, x=true.x - distance * float(true.contact_half_width.max()), time=true.time)
    return compare(true, replace(true, pressure=other.pressure, shear=other.shear))


def last_revolution(scene: Scene, rows: np.ndarray, other: ContactSolution) -> Comparison:
    """The last revolution's tractions replaced by rows of `other`."""
    true = truth(scene.name)
    pressure, shear = true.pressure.copy(), true.shear.copy()
    pressure[true.last_cycle], shear[true.last_cycle] = other.pressure[rows], other.shear[rows]
    return compare(true, replace(true, pressure=pressure, shear=shear))


def late(scene: Scene, delay: float) -> Comparison:
    """So much of a period late, in the last revolution."""
    true = truth(scene.name)
    time = true.time[true.last_cycle] - delay * (scene.load.path().period or 0.0)
    return last_revolution(scene, np.arange(len(time)), semi_analytic.solve(scene, x=true.x, time=time))


def solved(scene: Scene, mesh: MeshSettings = MESH, **settings: Any) -> Comparison:
    """Finite elements against half-plane theory at the same points and instants."""
    return beside_theory(halfplane_fe.solve(scene, mesh, SolverSettings(**settings)))


def few_steps(scene: Scene, steps: float) -> Comparison:
    """Increments that land on no event. On a polygon, whose corners they can't miss, theory on straight lines that do."""
    if isinstance(scene.load, EllipseLoad):
        with must_fail.blind():
            return solved(scene, steps_per_cycle=int(steps), step_tolerance=float("inf"))
    x, time = truth(scene.name).x, times(scene, int(steps) + 1)
    reference, polygon = (semi_analytic.solve(scene, x=x, time=time, straight_steps=straight) for straight in (False, True))
    return compare(reference, replace(polygon, scene=scene), polygon_reference=polygon)


def forgetful(scene: Scene, _severity: float) -> Comparison:
    """Each increment starts from faces that have never slipped; few of them, for they never settle."""
    with must_fail.equilibrium(must_fail.forgetting):
        return solved(scene, steps_per_cycle=32, step_tolerance=float("inf"))


def blocks(scene: Scene, height: float) -> Comparison:
    """Two blocks, twice as wide as high, in place of half-planes."""
    block = {"kind": "block", "width": 2 * height, "height": height}
    return solved(scene.vary(bodies=Bodies.model_validate({"lower": block, "upper": block})))


def unlike(scene: Scene, poisson_ratio: float) -> Comparison:
    """The upper body with another nu."""
    upper = scene.material.upper.vary(poisson_ratio=poisson_ratio)
    return solved(scene.vary(material=Materials(upper=upper, lower=scene.material.lower)))


def soft(name: str) -> Plant:
    """A penalty of so many E*/a, the other one stiff; the solver's own unit is E*/h, h being that of the edges."""
    stiff: dict[str, Any] = {"normal_stiffness": 1e4, "tangential_stiffness": 1e4}
    return lambda scene, severity: solved(scene, method="penalty", **(stiff | {name: severity * MESH.edge_element_size}))


def coarse(scene: Scene, size: float) -> Comparison:
    return solved(scene, MeshSettings(element_size=size, edge_element_size=size))


def rougher(scene: Scene, factor: float) -> Scene:
    return with_friction(scene, factor * scene.friction.coefficient)


@dataclass(frozen=True)
class Fault:
    """What is planted, from strong to mild, and how: scene and severity to a comparison."""

    severities: tuple[float, ...]
    plant: Plant


_BOTH: dict[str, Any] = {"pressure": lambda true, k: k * true.pressure, "shear": lambda true, k: k * true.shear}
_SWAP: dict[str, Any] = {"pressure": lambda true, _: true.shear, "shear": lambda true, _: true.pressure}
FAULTS = {
    "shear_sign": Fault((1.0,), altered(shear=lambda true, _: -true.shear)),
    "pressure_sign": Fault((1.0,), altered(pressure=lambda true, _: -true.pressure)),
    "swapped": Fault((1.0,), altered(**_SWAP)),
    "frictionless": Fault((1.0,), altered(shear=lambda true, _: 0 * true.shear)),
    "units": Fault((1e6, 1e-3, 10.0), altered(**_BOTH)),
    "traction_factor": Fault((1.5, 1.1, 1.02), altered(**_BOTH)),
    "pressure_factor": Fault((1.5, 1.1, 1.01), altered(pressure=_BOTH["pressure"])),
    "offset": Fault((0.3, 0.03, 0.01, 0.001), moved),
    "stiffness": Fault((2.0, 0.91, 0.97, 0.99, 0.998), asked(stiffer)),
    # Loads times a factor: by linearity the tractions of bodies that much more compliant, times the factor.
    "half_model": Fault((0.5, 2.0), asked(lambda scene, k: stiffer(scene, 1 / k), lambda k: k)),
    "loads": Fault((1.3, 1.05, 1.01, 1.002), asked(lambda scene, k: stiffer(scene, 1 / k), lambda k: k)),
    "friction": Fault((1.5, 1.1, 0.97, 1.01), asked(rougher)),
    "full_stick": Fault((50.0,), asked(rougher)),
    "memoryless": Fault((1.0,), forgetful),
    "not_steady": Fault((1.0,), lambda scene, _: last_revolution(scene, np.arange(4, 5 + INSTANTS), truth(scene.name))),
    "other_times": Fault((0.25, 0.05, 0.01, 0.002), late),
    "steps": Fault((4.0, 8.0, 12.0, 24.0, 48.0), few_steps),
    "elastic_slip": Fault((2.4, 7.2, 24.0, 72.0, 240.0), soft("tangential_stiffness")),
    "soft_normal": Fault((12.0, 24.0, 72.0, 240.0), soft("normal_stiffness")),
    "small_body": Fault((2.5, 4.0, 8.0, 16.0), blocks),
    "coupling": Fault((0.45, 0.4, 0.35), unlike),
    "coarse_edge": Fault((1 / 5, 1 / 8, 1 / 12, 1 / 24), coarse),
}


def confusion() -> Iterator[Row]:
    """Of each fault how many results out of tolerance were told wrong; then the share of all."""
    seen, wrong = 0, 0
    for key, fault in FAULTS.items():
        made = [(name, severity) for name in SCENES for severity in fault.severities]
        told = [(*one, diagnose(fault.plant(load_scene(one[0]), one[1]))) for one in made]
        said = [(found[0].fault, f"{name} at {severity:g}: {found[0].fault}") for name, severity, found in told if found]
        off = [words for first, words in said if first != key]
        seen, wrong = seen + len(said), wrong + len(off)
        yield Row(f"{key}: first diagnosis wrong", len(off), None, f"{len(said)} results out of tolerance; {'; '.join(off)}")
    yield Row("first diagnosis wrong, all faults, scenes and severities", wrong / seen, 0.05, f"{seen} results out of tolerance")


# -------------------------------------------------------------------------------------------------------- rules and readers
def rule_rows() -> Iterator[Row]:
    """The rules of the score on right results: theory's own fields, our own field files, CalculiX' decks of tests/data."""
    scene = load_scene("hertz-paper")
    path = scene.load.path()
    assert path.period is not None
    x = np.linspace(-1.3, 1.3, 105)
    own, few = (
        semi_analytic.solve(scene, x=x, time=path.cycle_start + path.period * np.linspace(1, 2, instants)) for instants in (25, 21)
    )
    peak = score(own.x, own.pressure, own.shear, scene=scene).metric("peak_pressure").value
    how = "hertz-paper, 25 instants found from the integrals of p and q over 105 points"
    yield Row("instants from integrals: peak pressure", float(peak or 0.0), 5e-5, how)
    work = float(np.trapezoid(friction_work(few.shear, few.slip), x))
    how = "hertz-paper, theory's own fields at 105 points"
    yield Row("sum of q ds over a cycle of 21 instants: too little by", 100 * (1 - work / few.dissipation), None, how, "%")

    fe = halfplane_fe.solve(scene)
    steps = fe.last_cycle
    own = semi_analytic.solve(scene, x=fe.x, time=fe.time[steps])
    found = zones(own.x, own.pressure, own.shear, None, scene.friction.coefficient, own.time)
    off = np.max(np.abs(found.stick_edges - own.stick_edges), axis=1) / scales(own).half_width
    both = np.isnan(found.stick_edges[:, 0]) == np.isnan(own.stick_edges[:, 0])
    how = f"hertz-paper, theory at the {len(fe.x)} points and {len(steps)} instants of a cycle of the finite elements"
    yield Row("stick edge without slip, off by up to", float(np.nanmax(off)), None, how, "a")
    yield Row(f"instants at which it is off by more than {UNTOLD:g} a", float(np.sum(~both | (off > UNTOLD))), None, how)
    yield Row("... of so many", float(len(steps)), None, how)

    instants = [instant.time for instant in instants_of(["events"], fe, "fields")]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        collection = folder / write_fields(fe, halfplane_fe.fields(fe, instants), folder)[0]
        whole = read(collection, Mapping())
        for file in folder.glob("contact_*.vtu"):
            file.unlink()
        bodies = [line for line in collection.read_text(encoding="utf-8").splitlines() if "contact_" not in line]
        collection.write_text("\n".join(bodies), encoding="utf-8")
        stress = read(collection, Mapping())  # nodal stress alone, as files without tractions have it
    rows = [int(np.argmin(np.abs(fe.time - time))) for time in instants]
    apart = max(float(np.max(np.abs(a - b[rows]))) for a, b in ((whole.pressure, fe.pressure), (whole.shear, fe.shear)))
    how = (
        f"hertz-paper, all three parts of the fields at {len(instants)} events, against the run that wrote them; over the largest p"
    )
    yield Row("fields.pvd of our own: tractions read back, off by", apart / float(fe.pressure.max()), 0.0, how)
    normal, tangential = path.at(np.asarray(stress.time))
    carries = np.abs(tangential) > 0.1 * normal
    touching = stress.pressure > TOUCHES * stress.pressure.max(axis=1, keepdims=True)
    inside, over_face = (
        np.trapezoid(q, stress.x, axis=1)[carries] / tangential[carries]
        for q in (np.where(touching, stress.shear, 0), stress.shear)
    )
    how = f"hertz-paper, fields of both bodies at {len(normal)} events of a cycle, worst of them; Q where it is more than 0.1 P"
    pressure = np.trapezoid(stress.pressure, stress.x, axis=1) / normal
    yield Row("nodal stress: p adds up to P, off by", float(np.max(np.abs(pressure - 1))), None, how)
    yield Row("nodal stress: q within the contact adds up to Q, off by", float(np.max(np.abs(inside - 1))), None, how)
    worst = float(over_face[np.argmax(np.abs(over_face - 1))])
    yield Row("nodal stress: q over the whole face, over Q", worst, None, how)
    for kind, forms in (("node to surface", (".frd", ".dat")), ("mortar", (".frd",)), ("surface to surface", (".frd", ".dat"))):
        for suffix in forms:
            file = ROOT / "tests" / "data" / f"{kind.replace(' ', '-')}{suffix}"
            deck = read(file, Mapping())
            share = np.trapezoid(deck.pressure[-1], deck.x) / DECK_LOAD
            how = f"tests/data/{file.name}, last instant; trapezia over the pressures"
            yield Row(f"{kind}, {suffix}: adds up to P, off by", 100 * float(share - 1), None, how, "%")


def example_rows() -> Iterator[Row]:
    """One headline figure of each example of docs/examples/score; the table of Abaqus' form has no dissipation."""
    sys.path.insert(0, str(ROOT / "docs" / "examples" / "score"))
    import measure

    for example in measure.EXAMPLES:
        report = measure.scored(example)
        metric, pressure = report.metric("shear" if example.name == "abaqus" else "dissipation"), report.metric("pressure").value
        faults = ", ".join(one.fault for one in report.diagnoses)
        how = f"{measure.SCENE}, {example.result}; p, relative L2: {pressure:.2g}; diagnosis: {faults}"
        yield Row(f"score of the example {example.name}: {metric.label}", float(metric.value), None, how)
