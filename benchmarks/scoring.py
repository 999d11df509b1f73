"""What `halfplane score` gets wrong: its rules on right results, its diagnoses of results with a
planted fault.

A fault is planted in a file by altering its arrays, in a question by solving another one, in a
model by running the finite elements with it. One so mild that the result stays within the scene's
tolerances is not seen, and shall not be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import must_fail
import numpy as np
from claims import ROOT, Row
from covered import beside_theory

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports import Comparison, compare, score
from reports.comparison.pairs import scales_of_reference
from reports.scoring.diagnosis import diagnose
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read_result
from reports.scoring.solution import friction_work, zones_of_tractions
from reports.scoring.traces import NOISE, UNKNOWN
from reports.scoring.variants import scene_with_friction, scene_with_modulus_factor
from scenes import Bodies, ContactSolution, EllipseLoad, Materials, Scene, load_scene

SCENES = ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper")
# The default mesh, on which a healthy run is within tolerance: the fault is planted alone, with no
# coarseness beside it.
MESH = MeshSettings()
INSTANTS = 60
POINTS = 121
DECK_LOAD = 400.0  # P of the decks of tests/data [force / thickness]
Plant = Callable[[Scene, float], Comparison]


# --------------------------------------------------------------------- results with a planted fault
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
    return semi_analytic.solve(
        scene, x=np.linspace(-1.3 * half, 1.3 * half, POINTS), time=times(scene)
    )


def altered(
    pressure: Callable[..., Any] = lambda p, q, k: p, shear: Callable[..., Any] = lambda p, q, k: q
) -> Plant:
    """The truth, but for its tractions: of p, q and the severity."""

    def plant(scene: Scene, severity: float) -> Comparison:
        true = truth(scene.name)
        arguments = true.pressure, true.shear, severity
        return compare(true, replace(true, pressure=pressure(*arguments), shear=shear(*arguments)))

    return plant


def asked(
    change: Callable[[Scene, float], Scene], factor: Callable[[float], float] = lambda _: 1.0
) -> Plant:
    """The truth of another scene, its tractions times a factor."""

    def plant(scene: Scene, severity: float) -> Comparison:
        true = truth(scene.name)
        k = factor(severity)
        changed_answer = semi_analytic.solve(change(scene, severity), x=true.x, time=true.time)
        return compare(
            true,
            replace(
                changed_answer,
                scene=scene,
                pressure=k * changed_answer.pressure,
                shear=k * changed_answer.shear,
            ),
        )

    return plant


def stretched(scene: Scene, factor: float) -> Comparison:
    """Places times a factor."""
    true = truth(scene.name)
    changed_answer = semi_analytic.solve(scene, x=true.x / factor, time=true.time)
    return compare(
        true, replace(true, pressure=changed_answer.pressure, shear=changed_answer.shear)
    )


def moved(scene: Scene, distance: float) -> Comparison:
    """The centre off by so much of the largest half-width."""
    true = truth(scene.name)
    changed_answer = semi_analytic.solve(
        scene, x=true.x - distance * float(true.contact_half_width.max()), time=true.time
    )
    return compare(
        true, replace(true, pressure=changed_answer.pressure, shear=changed_answer.shear)
    )


def last_revolution(scene: Scene, answer: ContactSolution, rows: slice = slice(None)) -> Comparison:
    """The last revolution's tractions replaced by rows of `other`."""
    true = truth(scene.name)
    pressure = true.pressure.copy()
    shear = true.shear.copy()
    pressure[true.last_cycle] = answer.pressure[rows]
    shear[true.last_cycle] = answer.shear[rows]
    return compare(true, replace(true, pressure=pressure, shear=shear))


def late(scene: Scene, delay: float) -> Comparison:
    """So much of a period late, in the last revolution."""
    true = truth(scene.name)
    time = true.time[true.last_cycle] - delay * (scene.load.path().period or 0.0)
    return last_revolution(scene, semi_analytic.solve(scene, x=true.x, time=time))


def solved(scene: Scene, mesh: MeshSettings = MESH, **settings: Any) -> Comparison:
    """Finite elements against half-plane theory at the same points and instants."""
    return beside_theory(halfplane_fe.solve(scene, mesh, SolverSettings(**settings)))


def few_steps(scene: Scene, steps: float) -> Comparison:
    """Increments that land on no event. On a polygon, whose corners they can't miss, theory on
    straight lines that do.
    """
    if isinstance(scene.load, EllipseLoad):
        with must_fail.blind():
            return solved(scene, steps_per_cycle=int(steps), step_tolerance=float("inf"))
    x = truth(scene.name).x
    time = times(scene, int(steps) + 1)
    reference, polygon = (
        semi_analytic.solve(scene, x=x, time=time, straight_steps=straight)
        for straight in (False, True)
    )
    return compare(reference, replace(polygon, scene=scene), polygon_reference=polygon)


def forgetful(scene: Scene, _severity: float) -> Comparison:
    """Each increment starts from faces that have never slipped; few of them, for they never
    settle.
    """
    with must_fail.equilibrium(must_fail.forgetting):
        return solved(scene, steps_per_cycle=32, step_tolerance=float("inf"))


def blocks(scene: Scene, height: float) -> Comparison:
    """Two blocks, twice as wide as high, in place of the half-planes that the scene states."""
    block = {"kind": "block", "width": 2 * height, "height": height}
    bodies = Bodies.model_validate({"lower": block, "upper": block})
    answer = halfplane_fe.solve(scene.vary(bodies=bodies), MESH)
    return beside_theory(replace(answer, scene=scene))


def unlike(scene: Scene, poisson_ratio: float) -> Comparison:
    """The upper body with another nu."""
    upper = scene.material.upper.vary(poisson_ratio=poisson_ratio)
    return solved(scene.vary(material=Materials(upper=upper, lower=scene.material.lower)))


def soft(name: str) -> Plant:
    """A penalty of so many E*/a, the other one stiff; the solver's own unit is E*/h, h being that
    of the edges.
    """
    stiff: dict[str, Any] = {"normal_stiffness": 1e4, "tangential_stiffness": 1e4}
    return lambda scene, severity: solved(
        scene, method="penalty", **(stiff | {name: severity * MESH.edge_element_size})
    )


def rougher(scene: Scene, factor: float) -> Scene:
    return scene_with_friction(scene, factor * scene.friction.coefficient)


class Fault(NamedTuple):
    """What is planted, from strong to mild, and how: scene and severity to a comparison."""

    severities: tuple[float, ...]
    plant: Plant


# Loads times a factor are, by linearity, the tractions of bodies that much more compliant, times
# the factor.
FAULTS = {
    "shear_sign": Fault((1.0,), altered(shear=lambda p, q, _: -q)),
    "pressure_sign": Fault((1.0,), altered(lambda p, q, _: -p)),
    "swapped": Fault((1.0,), altered(lambda p, q, _: q, lambda p, q, _: p)),
    "frictionless": Fault((1.0,), altered(shear=lambda p, q, _: 0 * q)),
    "units": Fault((1e6, 1e-3, 10.0), altered(lambda p, q, k: k * p, lambda p, q, k: k * q)),
    "traction_factor": Fault(
        (1.5, 1.1, 1.02), altered(lambda p, q, k: k * p, lambda p, q, k: k * q)
    ),
    "pressure_factor": Fault((1.5, 1.1, 1.01), altered(lambda p, q, k: k * p)),
    "shear_factor": Fault((1.5, 1.1, 1.02), altered(shear=lambda p, q, k: k * q)),
    "x_scale": Fault((1.1, 0.5, 1.02), stretched),
    "offset": Fault((0.3, 0.03, 0.01, 0.001), moved),
    "stiffness": Fault((2.0, 0.91, 0.97, 0.99, 0.998), asked(scene_with_modulus_factor)),
    "half_model": Fault(
        (0.5, 2.0), asked(lambda scene, k: scene_with_modulus_factor(scene, 1 / k), lambda k: k)
    ),
    "loads": Fault(
        (1.3, 1.05, 1.01, 1.002),
        asked(lambda scene, k: scene_with_modulus_factor(scene, 1 / k), lambda k: k),
    ),
    "friction": Fault((1.5, 1.1, 0.97, 1.01), asked(rougher)),
    "full_stick": Fault((50.0,), asked(rougher)),
    "memoryless": Fault((1.0,), forgetful),
    "not_steady": Fault(
        (1.0,), lambda scene, _: last_revolution(scene, truth(scene.name), slice(4, 5 + INSTANTS))
    ),
    "other_times": Fault((0.25, 0.05, 0.01, 0.002), late),
    "steps": Fault((4.0, 8.0, 12.0, 24.0, 48.0), few_steps),
    "elastic_slip": Fault((2.4, 7.2, 24.0, 72.0, 240.0), soft("tangential_stiffness")),
    "soft_normal": Fault((12.0, 24.0, 72.0, 240.0), soft("normal_stiffness")),
    "small_body": Fault((2.5, 4.0, 8.0, 16.0), blocks),
    "coupling": Fault((0.45, 0.4, 0.35), unlike),
    "coarse_edge": Fault(
        (1 / 5, 1 / 8, 1 / 12, 1 / 24),
        lambda s, h: solved(s, MeshSettings(element_size=h, edge_element_size=h)),
    ),
}


def confusion() -> Iterator[Row]:
    """The share of results out of tolerance whose first diagnosis is another fault than the planted
    one; those of which no cause is found are counted apart.
    """
    n_seen = 0
    wrong = []
    silent = []
    for key, fault in FAULTS.items():
        for name, severity in (
            (name, severity) for name in SCENES for severity in fault.severities
        ):
            causes = diagnose(fault.plant(load_scene(name), severity))
            if not causes:
                continue
            n_seen += 1
            first = causes[0].fault
            words = f"{key} of {severity:g}, {name}"
            if first in (UNKNOWN, NOISE):
                silent.append(words)
            elif first != key:
                wrong.append(f"{words}: {first}")
    how = (
        f"{n_seen} results out of tolerance of {len(FAULTS)} faults;"
        f" {'; '.join(wrong) or 'none wrong'}; cause not found of {len(silent)}:"
        f" {'; '.join(silent) or 'none'}"
    )
    yield Row(
        "first diagnosis wrong, all faults, scenes and severities", len(wrong) / n_seen, 0.05, how
    )
    yield Row("cause not found, the same", len(silent) / n_seen, 0.1, how)


# -------------------------------------------------------------------------------- rules and readers
def rules() -> Iterator[Row]:
    """The rules of the score on right results: theory's own fields, CalculiX' decks of
    tests/data.
    """
    scene = load_scene("hertz-paper")
    path = scene.load.path()
    x = np.linspace(-1.3, 1.3, 105)
    exact, exact_at_few = (
        semi_analytic.solve(
            scene, x=x, time=path.cycle_start + (path.period or 0) * np.linspace(1, 2, count)
        )
        for count in (25, 21)
    )
    peak = score(exact.x, exact.pressure, exact.shear, scene=scene).metric("peak_pressure").value
    how = "hertz-paper, 25 instants found from the integrals of p and q over 105 points"
    yield Row("instants from integrals: peak pressure", float(peak or 0.0), 5e-5, how)
    work = float(np.trapezoid(friction_work(exact_at_few.shear, exact_at_few.slip), x))
    how = "hertz-paper, theory's own fields at 105 points"
    yield Row(
        "sum of q ds over a cycle of 21 instants: too little by",
        100 * (1 - work / exact_at_few.dissipation),
        None,
        how,
        "%",
    )
    fe = halfplane_fe.solve(scene)
    exact = semi_analytic.solve(scene, x=fe.x, time=fe.time[fe.last_cycle])
    zones_found = zones_of_tractions(
        exact.x, exact.pressure, exact.shear, None, scene.friction.coefficient, exact.time
    )
    off = (
        np.max(np.abs(zones_found.stick_edges - exact.stick_edges), axis=1)
        / scales_of_reference(exact).half_width
    )
    how = (
        f"hertz-paper, theory at the {len(exact.x)} points and {len(exact.time)} instants of a"
        " cycle of the finite elements"
    )
    yield Row("stick edge without slip, off by up to", float(np.nanmax(off)), None, how, "a")
    for kind, suffixes in (
        ("node to surface", (".frd", ".dat")),
        ("mortar", (".frd",)),
        ("surface to surface", (".frd", ".dat")),
    ):
        for suffix in suffixes:
            file = ROOT / "tests" / "data" / f"{kind.replace(' ', '-')}{suffix}"
            deck = read_result(file, Mapping())
            share = float(np.trapezoid(deck.pressure[-1], deck.x) / DECK_LOAD - 1)
            how = f"tests/data/{file.name}, last instant; trapezia over the pressures"
            yield Row(f"{kind}, {suffix}: adds up to P, off by", 100 * share, None, how, "%")
