"""Numerical stress: what both engines do at the ends of what a scene may ask, written to docs/stress.md.

    make stress                                    (python benchmarks/stress.py, ten minutes)
    python benchmarks/stress.py "flat face" ...    (only cases whose names hold one of these; the others stay as found)
    python benchmarks/stress.py --pages            (none: the page from stress.json)

What was found is kept in stress.json, case by case with its day; the page is written from that. A case is a list of trials. A trial
gives an error, to be at most the limit, or is refused by InputError or ConvergenceError; anything else, a warning included, breaks
the case.
"""

from __future__ import annotations

import functools
import sys
import tempfile
import time
import tracemalloc
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import mpmath
import numpy as np
import regress_truth
from claim import kept_json, markdown, write_json
from half_plane import PROFILES, batch, classes, like, table_of_ellipses

import halfplane_fe
import meshes
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import BodyMesh, MeshSettings, mesh_quality
from scenes import (
    Block,
    Bodies,
    ContactSolution,
    ConvergenceError,
    Elastic,
    EllipseLoad,
    FlatRounded,
    Friction,
    Hertz,
    InputError,
    Materials,
    PolygonLoad,
    PowerLaw,
    Profile,
    Scene,
    TimeSeriesLoad,
    Wedge,
    load_scene,
)
from semi_analytic.elasticity import composite_modulus
from semi_analytic.friction_work import global_dissipation
from semi_analytic.history import history_of
from semi_analytic.profiles import contact_of

PAGE, KEPT = Path(__file__).parents[1] / "docs" / "stress.md", Path(__file__).with_suffix(".json")
HALF_PLANE, FE = "Half-plane engine", "Finite elements"
BOTH_SIGNS = [(length, stress) for stress in (1e-12, 1e12) for length in (1e-12, 1e12)]
LOOP = (3.0, 1.0, 0.2, 0.8, 70.0)
COARSE, FEW = MeshSettings.coarse(), SolverSettings(steps_per_cycle=32)
ROUGH = replace(COARSE, element_size=1 / 4, edge_element_size=1 / 8)
COARSEST = replace(ROUGH, edge_element_size=1 / 4)
# Limit of the errors of p, q and W, each for itself: above it the solver has to say so. A few times what a coarse mesh promises of
# the shear (about 1 % in L2): what a reader of a first look takes for good if nothing is said.
STATED = 0.05
# Instants at which tractions are compared, of the last revolution and with more than this share of the largest load.
INSTANTS, LOADED = 16, 0.3
# Half-width a of `LOOP` at its largest load on half-planes, in the scene's lengths; above which a law is broken.
HALF_WIDTH, BROKEN = 22.6, 1e-7


@dataclass(frozen=True)
class Found:
    """What a trial measured: errors held against the limit, the answer's own notes, values that are only shown."""

    errors: Mapping[str, float]
    notes: tuple[str, ...] = ()
    shown: Mapping[str, float] = field(default_factory=dict)


Trial = tuple[str, Callable[[], "float | Found"]]


@dataclass(frozen=True)
class Case:
    """A few trials of one kind.

    Attributes
    ----------
    engine, what, tried : who, which end of the range, and the values
    measure, limit : what the error is of and against what, and how large each may be
    trials : (name, function that gives errors or refuses)
    must_refuse : whether each of the trials has to end in a sentence
    may_tell : whether an error above the limit passes if the answer says so: it is shown with its note
    """

    engine: str
    what: str
    tried: str
    measure: str
    limit: float
    trials: Callable[[], Iterable[Trial]]
    must_refuse: bool = False
    may_tell: bool = False

    @property
    def name(self) -> str:
        return f"{self.engine}: {self.what}"


@dataclass
class Outcome:
    """What became of a case: worst errors of the trials that were answered, what was stated, who refused, what broke."""

    worst: dict[str, float] = field(default_factory=dict)
    shown: dict[str, float] = field(default_factory=dict)
    right: int = 0
    told: list[str] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    seconds: float = 0.0
    day: str = ""

    @property
    def verdict(self) -> str:
        """Every trial accounted for."""
        if self.broken:
            return "**broken**: " + "; ".join(self.broken)
        words = [f"right ({self.right})" if self.told else "right"] if self.right else []
        words += [f"told: {sentence}" for sentence in self.told]
        return "; ".join([*words, *(f"refused: “{sentence}”" for sentence in self.refused)])

    def count(self, case: Case, name: str, found: float | Found) -> None:
        """One trial that was answered: right, in error and stated, or wrong and silent."""
        result = found if isinstance(found, Found) else Found({"": float(found)})
        for target, source in ((self.worst, result.errors), (self.shown, result.shown)):
            for key, value in source.items():
                target[key] = float(np.maximum(target.get(key, 0.0), value))
        off = {key: value for key, value in result.errors.items() if not value <= case.limit}
        values = _values({**off, **(result.shown if "W" in off else {})})
        if not off:
            self.right += 1
        elif case.may_tell and result.notes and np.isfinite([v for k, v in off.items() if k != "W"]).all():
            self.told.append(f"{name}: {values}, with the note “{'” and “'.join(result.notes)}”")
        else:
            self.broken.append(f"{name}: wrong, silent: {values}" if case.may_tell else f"{name}: {values}")


def _values(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.1e}".strip() for name, value in values.items())


def outcome(case: Case) -> Outcome:
    """Every trial of a case, warnings being errors."""
    found, started = Outcome(), time.perf_counter()
    for name, trial in case.trials():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                answer = trial()
        except (InputError, ConvergenceError) as reason:
            sentence = f"{reason}".splitlines()[0]
            found.refused += [] if sentence in found.refused else [sentence]
            found.broken += [] if case.must_refuse else [f"{name}: refused, {reason}"]
        except Exception as reason:  # noqa: BLE001 - a traceback is what is looked for: it is counted and shown
            found.broken.append(f"{name}: {type(reason).__name__}: {reason}")
        else:
            found.count(case, name, answer)
    if case.must_refuse and found.worst:
        found.broken.append("a trial was answered")
    found.seconds, found.day = time.perf_counter() - started, datetime.now(UTC).date().isoformat()
    return found


# ------------------------------------------------------------------------------------------------------------------- scenes
def scene_of(load: Any, friction: float = 0.5, profile: Profile | None = None, material: Materials | None = None) -> Scene:
    """Hertz of radius 100 and E* = 1 where nothing else is said."""
    profile, material = profile or Hertz(radius=100.0), material or like(1.0)
    return Scene(name="stress", material=material, profile=profile, friction=Friction(coefficient=friction), load=load)


def ellipse(p0: float, p1: float, q0: float, q1: float, phase: float) -> EllipseLoad:
    """P0, P1, Q0, Q1 and the phase in degrees."""
    loads = {"mean_normal_load": p0, "normal_amplitude": p1, "mean_tangential_load": q0, "tangential_amplitude": q1}
    return EllipseLoad(**loads, phase_degrees=phase)


def to_and_fro(share: float, friction: float, load: float = 1.0) -> PolygonLoad:
    """Q between +-share f P at constant P."""
    force = share * friction * load
    return PolygonLoad(initial_loading=((load, 0.0),), cycle=((load, force), (load, -force)))


def mindlin(share: mpmath.mpf, friction: float) -> mpmath.mpf:
    """W of a cycle of Q between +-share f P at constant P = 1, E* = 1; finite at share = 1."""
    with mpmath.workdps(60):
        return regress_truth.mindlin(mpmath.mpf(share), mpmath.mpf(friction))


def broken_by(answer: ContactSolution) -> float:
    """The worst certificate."""
    return max(float(np.max(values)) for values in answer.record.certificates.values())


def work_of(scene: Scene) -> float:
    """W by the half-plane engine."""
    return float(semi_analytic.solve(scene, x=[0.0], fields=("dissipation",)).dissipation)


def each(function: Callable[..., float | Found], values: Iterable[Any], words: str = "{:g}") -> Callable[[], list[Trial]]:
    """A trial for each value, or tuple of values."""
    given = [value if isinstance(value, tuple) else (value,) for value in values]
    return lambda: [(words.format(*value), partial(function, *value)) for value in given]


def flat_loads(part: float, radius: float) -> tuple[FlatRounded, float]:
    """A flat face with b = part, and the load at which a = 1."""
    profile = FlatRounded(radius=radius, flat_half_length=part)
    return profile, float(contact_of(profile, like(1.0)).load(1.0))


# -------------------------------------------------------------------------------------------------------- half-plane engine
def of_mindlin(share: float, friction: float, over_stated: bool = False) -> float:
    """Relative error of W; over what the engine states of it with `over_stated`."""
    answer = semi_analytic.solve(scene_of(to_and_fro(share, friction), friction), x=[0.0], fields=("dissipation",))
    exact = mindlin(min(mpmath.mpf(share * friction) / mpmath.mpf(friction), 1), friction)
    error = abs(float(answer.dissipation / exact - 1))
    return error / answer.record.errors["dissipation"] if over_stated else error


def in_units(kind: str, length: float, stress: float) -> float:
    """Worst change of any dimensionless field, over its largest value."""
    x, amounts = np.linspace(-2.6, 2.6, 41), np.array([3.0, 1.0, 0.2, 0.8])
    one, other = (
        semi_analytic.solve(scene_of(ellipse(*(amounts * l * s), 70.0), 0.5, PROFILES[kind](l), like(s)), x=x * l)
        for l, s in ((1.0, 1.0), (length, stress))  # noqa: E741
    )
    units = {"pressure": stress, "shear": stress, "dissipation_density": length * stress}
    units |= dict.fromkeys(("slip", "tangential_displacement", "normal_approach", "contact_half_width", "stick_half_width"), length)
    errors = [
        float(np.nanmax(np.abs(getattr(other, n) / u - getattr(one, n))) / np.nanmax(np.abs(getattr(one, n))))
        for n, u in units.items()
    ]
    errors.append(abs(other.dissipation / (length**2 * stress) / one.dissipation - 1))
    return max(errors) if np.array_equal(one.state, other.state) else float("nan")


def in_proportion(friction: float) -> float:
    """W/f^2 of a loop whose Q is in proportion to f, against that of f = 1."""
    works = [work_of(scene_of(ellipse(3, 1, 0.4 * f, 1.6 * f, 70), f)) / f**2 for f in (1.0, friction)]
    return abs(works[1] / works[0] - 1)


def unloading(left: float) -> Found:
    """P0 - P1 = `left` P0 with Q in proportion to P up to the limit's half: W against 60 digits; Q dU beside it."""
    scene = scene_of(ellipse(1.0, 1 - left, 0.0, 0.2 * left, 90.0), 0.5)
    answer, load = semi_analytic.solve(scene, x=[0.0]), scene.load
    with mpmath.workdps(60):
        row = regress_truth.Case(0.0, 1.0, load.normal_amplitude, load.tangential_amplitude, mpmath.pi / 2, 0.5, True)
        exact = float(regress_truth.ellipse_dissipation(row))
    errors = {"W": abs(answer.dissipation / exact - 1), "cone and M(P) = Q, over f P": broken_by(answer)}
    return Found(errors, shown={"∮Q dU": abs(answer.loop_work / exact - 1)})


def tangent(friction: float, beyond: float) -> float:
    """W/(f P0)^2 over what may slip, of a line dQ/dP = f (1 + beyond)."""
    work = semi_analytic.solve(scene_of(ellipse(2, 1, 0.1 * friction, friction * (1 + beyond), 0), friction), x=[0.0]).dissipation
    return work / friction**2 / max(beyond, 2e-16 if beyond else 1e-300) if work else 0.0


def flat_face(part: float) -> Found:
    """A flat face with b/a = part at the largest load: W by formula, by slip areas and by Q dU, against 50 digits."""
    profile, load = flat_loads(part, 1.0)
    scene = scene_of(ellipse(0.75 * load, 0.25 * load, 0, 0.2 * load, 70), 0.5, profile)
    answer = semi_analytic.solve(scene, x=[0.0])
    spans = history_of(scene.load.path(), 0.5, scene.cycles).cycles[-1]
    areas = float(global_dissipation(contact_of(profile, like(1.0)), 1.0, spans).total)
    with mpmath.workdps(50):
        exact = float(regress_truth.steady_ellipse(scene))
    works = {"W": answer.dissipation, "slip areas": areas, "∮Q dU": answer.loop_work}
    return Found({name: abs(work / exact - 1) for name, work in works.items()} | {"cone": broken_by(answer)})


def steps(count: int) -> float:
    """n^2 (W/W_exact - 1) of the polygon of n steps a cycle; 1 for 1 and 2 steps, which have next to no loop."""
    scene = scene_of(ellipse(3, 1, 0.2, 0.8, 70))
    times = scene.load.path().cycle_start + 2 * np.pi * np.arange(3 * count + 1) / count
    rough = semi_analytic.solve(scene, x=[0.0], time=times, fields=("dissipation",), straight_steps=True).dissipation
    return count**2 * abs(rough / work_of(scene) - 1)


def wave(count: int, noise: float = 0.0, repeats: bool = False) -> np.ndarray:
    """Rows of a wave of 400 rows a period, with noise, clipped inside the cone."""
    rng, phase = np.random.default_rng(1), 2 * np.pi * np.arange(count) / 400
    normal = 3 + np.cos(phase) + noise * rng.standard_normal(count)
    force = 0.8 * np.cos(phase - 1.2) + noise * rng.standard_normal(count)
    rows = np.column_stack([np.arange(count), normal, np.clip(force, -0.45 * normal, 0.45 * normal)])
    if repeats:
        rows[-1, 1:] = rows[0, 1:]
    return rows


def of_rows(count: int, noise: float = 0.0, repeats: bool = False, change: Callable[[np.ndarray], None] | None = None) -> float:
    """Worst mismatch of M(P) = Q and the cone over all rows of a wave."""
    rows = wave(count, noise, repeats)
    if change:
        change(rows)
    answer = semi_analytic.solve(scene_of(TimeSeriesLoad(rows=rows, repeats=repeats)), x=[0.0], fields=("dissipation",))
    return broken_by(answer) if np.isfinite(answer.dissipation) and answer.dissipation > 0 else float("nan")


def held(rows: np.ndarray) -> None:
    rows[1000:300_000, 1:] = rows[1000, 1:]


def spike(rows: np.ndarray) -> None:
    rows[5000, 2] = 9.0


def nan(rows: np.ndarray) -> None:
    rows[500_000, 1] = np.nan


def unsorted(rows: np.ndarray) -> None:
    rows[[400, 500_000]] = rows[[500_000, 400]]


def twice(rows: np.ndarray) -> None:
    rows[777] = rows[776]


def cycles_of(period: np.ndarray, count: int, cycle: float) -> float:
    """What `count` periods of rows (m, 2) of P and Q dissipate beyond the second, against the W of a steady cycle."""

    def work(times: int) -> float:
        loads = np.concatenate([np.tile(period, (times, 1)), period[:1]])
        return work_of(scene_of(TimeSeriesLoad(rows=np.column_stack([np.arange(len(loads)), loads]))))

    return abs(float((work(count) - work(2)) / ((count - 2) * cycle) - 1))


def cycles_at_constant_load(count: int) -> float:
    period = np.column_stack([np.ones(400), 0.3 * np.cos(2 * np.pi * np.arange(400) / 400)])
    return cycles_of(period, count, mindlin(mpmath.mpf(0.3) / mpmath.mpf(0.5), 0.5))


def cycles_of_noise(count: int) -> float:
    """Of a noisy loop in which P varies, against W of a polygon of 400 corners."""
    period = wave(400, 0.01)[:, 1:]
    corners = tuple(map(tuple, period.tolist()))
    return cycles_of(period, count, work_of(scene_of(PolygonLoad(initial_loading=corners[:1], cycle=corners[1:]))))


def from_file(change: Callable[[np.ndarray], None]) -> float:
    """A million rows from a CSV file with a fault in it, through the door that everybody uses."""
    rows = wave(1_000_001)
    change(rows)
    with tempfile.TemporaryDirectory() as folder:
        np.savetxt(Path(folder) / "loads.csv", rows, delimiter=",", fmt="%.9g")
        text = (
            'profile = {kind = "hertz", radius = 100}\nmaterial = {young_modulus = 2, poisson_ratio = 0}\n'
            'friction = {coefficient = 0.5}\nload = {kind = "time_series", file = "loads.csv"}\n'
        )
        (Path(folder) / "scene.toml").write_text(text, encoding="utf-8")
        try:
            scene = load_scene(Path(folder) / "scene.toml")
        except InputError as reason:
            raise InputError(str(reason).replace(f"{folder}/", "")) from reason
    return work_of(scene)


def extremes(name: str) -> Callable[[], list[Trial]]:
    def trials() -> list[Trial]:
        rows = classes(table_of_ellipses(extremes=True))[name]
        return [(f"{name}, {k}", lambda r=row: abs(batch(r) / float(r["dissipation"]) - 1)) for k, row in enumerate(rows)]

    return trials


# ---------------------------------------------------------------------------------------------------------- finite elements
def against_theory(scene: Scene, mesh: MeshSettings = COARSE, settings: SolverSettings = FEW) -> Found:
    """Errors of p over ||p||, of q over f ||p||, in L2 at the worst instant, of W over W (infinite where nothing should slip).

    `shown` has that of W in A f^2 P^2 as well. NaN where a law is broken.
    """
    answer = halfplane_fe.solve(scene, mesh, settings)
    period = scene.load.path().period
    start = answer.time[-1] - period * (1 - 1e-9) if period is not None else -np.inf
    loaded = np.flatnonzero((answer.normal_load > LOADED * answer.normal_load.max()) & (answer.time > start))
    chosen = loaded[np.unique(np.linspace(0, len(loaded) - 1, INSTANTS).astype(int))]
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time[chosen], fields=("pressure", "shear"))

    def l2(values: np.ndarray) -> np.ndarray:
        return np.sqrt(values**2 @ answer.weights)

    work, size, friction = work_of(scene), l2(exact.pressure), scene.friction.coefficient
    unit = 2 / composite_modulus(scene.material) * (friction * answer.normal_load.max()) ** 2
    off = abs(answer.dissipation - work)
    errors = {
        "p": float(np.max(l2(answer.pressure[chosen] - exact.pressure) / size)),
        "q": float(np.max(l2(answer.shear[chosen] - exact.shear) / (friction * size))),
        "W": off / work if work else (np.inf if off else 0.0),
    }
    if broken_by(answer) > BROKEN:
        errors = dict.fromkeys(errors, float("nan"))
    return Found(errors, answer.record.notes, {"W in A f² P²": off / unit})


@functools.cache
def dimensionless(length: float, stress: float) -> dict[str, np.ndarray]:
    """Fields of one loop in units of length and stress."""
    scene = scene_of(ellipse(*(np.array(LOOP[:4]) * length * stress), LOOP[4]), 0.5, Hertz(radius=length), like(stress))
    answer = halfplane_fe.solve(scene, COARSE, FEW)
    units = {"pressure": stress, "shear": stress, "slip": length, "contact_edges": length, "dissipation_density": length * stress}
    return {name: getattr(answer, name) / unit for name, unit in units.items()}


def fe_in_units(length: float, stress: float) -> float:
    one, other = dimensionless(1.0, 1.0), dimensionless(length, stress)
    return max(float(np.max(np.abs(other[name] - one[name])) / np.max(np.abs(one[name]))) for name in one)


def pair(ratio: float, upper: float, lower: float) -> Materials:
    """E1/E2 = ratio with the two Poisson ratios, and E* = 1."""
    soft = (1 - upper**2) / ratio + (1 - lower**2)
    stiff = Elastic(young_modulus=ratio * soft, poisson_ratio=upper)
    return Materials(upper=stiff, lower=Elastic(young_modulus=soft, poisson_ratio=lower))


def exchanged(ratio: float) -> float:
    """W with the bodies exchanged, which is the same scene seen from below."""
    one = pair(ratio, 0.3, 0.3)
    both = one, Materials(upper=one.lower, lower=one.upper)
    works = [halfplane_fe.solve(scene_of(ellipse(*LOOP), material=material), COARSE, FEW).dissipation for material in both]
    return abs(works[1] / works[0] - 1)


def fe_flat_face(part: float) -> Found:
    profile, load = flat_loads(part, 100.0)
    return against_theory(scene_of(ellipse(0.75 * load, 0.25 * load, 0.05 * load, 0.2 * load, 70), 0.5, profile))


def many_steps(corners: int, count: int, mesh: MeshSettings = ROUGH) -> Found:
    """P, then Q to and fro between 0.6 and -0.6 f P over so many lines, `count` increments each: against 16 each, and the laws."""
    lines = tuple((1.0, 0.3 * (-1) ** number) for number in range(corners))
    scene = scene_of(PolygonLoad(initial_loading=((1.0, 0.0), *lines)))

    def solved(increments: int) -> ContactSolution:
        return halfplane_fe.solve(scene, mesh, SolverSettings(steps_per_cycle=8 * increments, step_tolerance=np.inf))

    many, few = solved(count), solved(16)
    if len(many.time) < count * (corners + 1):
        return Found({"increments missing": float("nan")})
    here, there = (np.searchsorted(answer.time, np.arange(1.0, corners + 1.5) - 1e-9) for answer in (many, few))
    off = {"W": abs(many.dissipation / few.dissipation - 1), "laws": max(broken_by(many), broken_by(few))}
    for symbol, name in (("p", "pressure"), ("q", "shear"), ("slip", "slip")):
        one, other = getattr(many, name)[here], getattr(few, name)[there]
        off[symbol] = float(np.max(np.abs(one - other)) / np.max(np.abs(other)))
    if mesh is not COARSEST:
        return Found(off)
    # Growth of the peak of memory with every increment more; fewer hide below what the condensation takes.
    peaks, sizes = [], []
    for increments in (300, 600):
        tracemalloc.start()
        sizes.append(len(solved(increments).time))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    return Found(off, shown={"kB an increment": (peaks[1] - peaks[0]) / (sizes[1] - sizes[0]) / 1000})


def squeezed(body: BodyMesh, share: float, count: int = 30) -> BodyMesh:
    """The body with `count` slivers: inner nodes, far and near, moved towards the opposite side of one of their triangles, of whose
    distance they keep that `share`.
    """
    mesh = body.mesh
    places, corners = mesh.doflocs.copy(), mesh.t

    def areas(at: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        (x0, y0), (x1, y1), (x2, y2) = (at[:, row] for row in triangles)
        return (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)

    taken = set(mesh.facets[:, mesh.boundary_facets()].ravel().tolist())
    moved: list[int] = []
    for number in np.random.default_rng(0).permutation(corners.shape[1]):
        node, *side = corners[:, number].tolist()
        if len(moved) == count or not taken.isdisjoint((node, *side)):
            continue
        star = corners[:, np.any(corners == node, axis=0)]
        trial, middle = places.copy(), np.mean(places[:, side], axis=1)
        trial[:, node] = middle + share * (places[:, node] - middle)
        if np.all(areas(trial, star) * areas(places, star) > 0):
            places, moved = trial, [*moved, node]
            taken.update(star.ravel().tolist())
    bent = np.flatnonzero(np.isin(mesh.facets, moved).any(axis=0))
    places[:, mesh.dofs.facet_dofs[0, bent]] = np.mean(places[:, mesh.facets[:, bent]], axis=1)
    if len(moved) < count:
        raise ValueError(f"only {len(moved)} nodes can be moved")
    made = replace(mesh, doflocs=places)
    return replace(body, mesh=made, quality=mesh_quality(made, 1.0))


def aspect(angle: float) -> float:
    """Length over height of a sliver with that least angle [degrees]."""
    return float(1 / np.tan(np.radians(angle)))


def with_slivers(share: float) -> Found:
    """Against the half-plane engine, both bodies squeezed; the worst aspect stands beside the errors."""
    angles = []

    def build(*arguments: Any) -> BodyMesh:
        body = squeezed(meshes.build(*arguments), share)
        angles.append(body.quality["least_angle"])
        return body

    with mock.patch("halfplane_fe.interface.build", build):
        found = against_theory(scene_of(ellipse(*LOOP)))
    return replace(found, shown={**found.shown, "aspect": aspect(min(angles))})


def on_block(width: float, height: float) -> Found:
    """Largest p and W on a block, sizes over the half-width, against elements half as long; NaN where a law is broken."""
    scene = scene_of(ellipse(*LOOP)).vary(bodies=Bodies(lower=Block(width=width * HALF_WIDTH, height=height * HALF_WIDTH)))
    finer = replace(COARSE, element_size=COARSE.element_size / 2, edge_element_size=COARSE.edge_element_size / 2)
    answer, better = (halfplane_fe.solve(scene, mesh, FEW) for mesh in (COARSE, finer))
    p, w = answer.pressure.max() / better.pressure.max(), answer.dissipation / better.dissipation
    off = {"p": abs(float(p) - 1), "W": abs(w - 1)}
    if max(broken_by(answer), broken_by(better)) > BROKEN:
        off = dict.fromkeys(off, float("nan"))
    return Found(off, answer.record.notes, {"aspect": aspect(answer.bodies[0].quality["least_angle"])})


def changed_mesh(change: dict[str, Any]) -> Found:
    return against_theory(scene_of(ellipse(*LOOP)), replace(COARSE, **change))


def refused_mesh(change: dict[str, Any]) -> float:
    return float(replace(COARSE, **change).growth)


# -------------------------------------------------------------------------------------------------------------------- cases
def half_plane_cases() -> Iterator[Case]:
    case = partial(Case, HALF_PLANE)
    exact, refused = "W against the closed form", {"limit": 0.0, "must_refuse": True, "measure": "refused"}
    units = [(kind, *unit) for kind in PROFILES for unit in BOTH_SIGNS]
    tried, measure = (
        "lengths and stresses times 1e-12 and 1e12, eight kinds of profile",
        "any field over its largest value, any state",
    )
    yield case("units", tried, measure, 1e-12, each(in_units, units, "{}, lengths {:g}, stresses {:g}"))
    shares = [(share, friction) for friction in (1e-6, 1e-3, 1.0, 100.0) for share in (0.3, 0.9)]
    yield case(
        "friction", "f = 1e-6, 1e-3, 1, 100; Q to 0.3 and 0.9 f P", exact, 1e-12, each(of_mindlin, shares, "{:g} f P, f = {:g}")
    )
    proportion = each(in_proportion, (1e-6, 1e-3, 100.0))
    yield case("friction, ellipse", "f = 1e-6 to 100, Q in proportion", "W/f² against that of f = 1", 1e-12, proportion)
    sliding = each(of_mindlin, [(1 - left, 0.5) for left in (1e-6, 1e-9, 1e-12, 1e-15, 0.0)], "{!r} f P")
    yield case("near gross sliding", "1e-6 to 1e-15 of f P left, and none", exact, 1e-12, sliding)
    tiny = each(of_mindlin, [(10.0**-power, 0.3, True) for power in range(4, 15)])
    yield case("next to no slip", "Q to 1e-4 ... 1e-14 of f P, a polygon", "error of W over the error that is told", 1.0, tiny)
    for name in classes([]):
        yield case(f"ellipses: {name}", "stored table, batch", "W against 30 digits", 1e-10, extremes(name))
    yield case(
        "next to no load",
        "P_min/P0 = 1e-3, 1e-6, 1e-9, 1e-12",
        "W against 60 digits; cone; in brackets the second route, whose rounding is told",
        1e-12,
        each(unloading, (1e-3, 1e-6, 1e-9, 1e-12)),
    )
    lines = [(f, beyond) for f in (1e-6, 1 / 3, 1.0, 100.0) for beyond in (-1e-12, -1e-15, 0.0, 2e-16, 1e-15, 1e-12)]
    tried, measure = "dQ/dP = f (1 + e), e = -1e-12 ... 1e-12, f from 1e-6 to 100", "W over e f² P², 0 for e ≤ 0"
    yield case("tangency within rounding", tried, measure, 1.0, each(tangent, lines, "f = {:g}, e = {:g}"))
    flat = each(flat_face, (1e-9, 1e-6, 1e-3, 0.9, 0.999, 1 - 1e-6, 1 - 1e-9))
    yield case("flat face", "b/a = 1e-9 ... 1 - 1e-9", "W, slip areas and closed integral against 50 digits; cone", 1e-10, flat)
    tried, measure = "1, 2, 10, 100, 1000, 10^4 straight steps a cycle", "n² times the error of W (second order)"
    yield case("step sizes", tried, measure, 8.0, each(steps, (1, 2, 10, 100, 1000, 10_000), "{}"))
    rows = [(100_001, 0.0), (1_000_001, 0.0), (1_000_001, 0.01), (1_000_001, 0.0, False, held), (100_001, 0.01, True)]
    tried = "10^5 and 10^6 rows, smooth, noisy, with repeats, again and again"
    yield case("long histories", tried, "cone and M(P) = Q, over f P", 1e-12, each(of_rows, rows, "{} rows, noise {:g}"))
    known = [(f"{400 * n} rows", partial(of, n)) for n in (250, 2500) for of in (cycles_at_constant_load, cycles_of_noise)]
    tried = "10^5 and 10^6 rows: 250 and 2500 cycles at constant P, and of a noisy loop"
    measure = "W of all but two cycles against the closed form, or a polygon's"
    yield case("long histories, W", tried, measure, 1e-10, lambda: known)
    tried = "10^6 rows from CSV: a NaN, a row out of order, a time twice"
    yield case("bad histories", tried, trials=each(from_file, (nan, unsorted, twice), "{.__name__}"), **refused)
    yield case("a spike", "one of 10^6 rows slides", trials=each(of_rows, [(1_000_001, 0.0, False, spike)], "{}"), **refused)


def fe_cases() -> Iterator[Case]:
    def stated(what: str, tried: str, function: Callable[..., Found], values: Iterable[Any]) -> Case:
        measure = "p, q in L2 and W, against the half-plane engine"
        return Case(FE, what, tried, measure, STATED, each(function, values, "{}"), may_tell=True)

    def refused(what: str, tried: str, function: Callable[..., float | Found], values: Iterable[Any]) -> Case:
        return Case(FE, what, tried, "refused", 0.0, each(function, values, "{}"), must_refuse=True)

    def of_load(load: Callable[[float], Any], **more: Any) -> Callable[[float], Found]:
        return lambda value: against_theory(scene_of(load(value), **more))

    def of_loop(change: Callable[[float], dict[str, Any]]) -> Callable[[float], Found]:
        return lambda value: against_theory(scene_of(ellipse(*LOOP), **change(value)))

    def of_friction(f: float) -> Found:
        return against_theory(scene_of(ellipse(3, 1, 0.4 * f, 1.6 * f, 70), f))

    def of_ratio(ratio: float) -> Found:
        nus = (0.4999, 0.2) if ratio < 1 else (0.2, 0.4999)  # the soft one incompressible: beta next to 0
        return against_theory(scene_of(ellipse(*LOOP), material=pair(ratio, *nus)))

    def of_tip(exponent: float) -> Found:
        tip = PowerLaw(exponent=exponent, length=1.0, rise=0.5) if exponent else Wedge(tip_radius=1.0, tip_half_length=0.1)
        return against_theory(scene_of(ellipse(*LOOP), profile=tip))

    def of_steps(count: int) -> Found:
        return against_theory(scene_of(ellipse(*LOOP)), COARSE, SolverSettings(steps_per_cycle=count))

    def changes(name: str, *values: Any) -> list[dict[str, Any]]:
        return [{name: value} for value in values]

    sliding = of_load(lambda left: to_and_fro(1 - left, 0.5))
    little = of_load(lambda part: ellipse(1, 1 - part, 0, 0.2 * part, 90))
    scaled = each(fe_in_units, BOTH_SIGNS, "lengths {:g}, stresses {:g}")
    yield Case(FE, "units", "lengths and stresses times 1e-12 and 1e12", "any field over its largest value", 1e-9, scaled)
    yield stated("friction", "f = 1e-6, 1e-3, 1, 100, Q in proportion", of_friction, (1e-6, 1e-3, 1.0, 100.0))
    yield stated("near gross sliding", "1e-3 ... 1e-15 of f P left", sliding, (1e-3, 1e-6, 1e-9, 1e-12, 1e-15))
    yield refused("at gross sliding", "Q = f P", sliding, (0.0,))
    narrow = of_load(lambda share: to_and_fro(share, 0.5))
    tried = "Q to 0.3 ... 1e-12 of f P: 5 to 2e-11 elements"
    yield stated("slip zones smaller than an element", tried, narrow, (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-6, 1e-12))
    yield stated("next to no load", "P_min/P0 = 1e-3, 1e-6, 1e-9", little, (1e-3, 1e-6, 1e-9))
    yield refused("less than rounding of the load", "P_min/P0 = 1e-12", little, (1e-12,))
    nus = of_loop(lambda nu: {"material": like(1.0, nu)})
    yield stated("Poisson's ratio", "nu = -0.9, 0, 0.4999, 0.499999", nus, (-0.9, 0.0, 0.4999, 0.499999))
    tried = "E1/E2 = 1e-6 ... 1e6, the soft body incompressible"
    yield stated("stiffness ratio, uncoupled", tried, of_ratio, (1e-6, 1e-3, 1e3, 1e6))
    tried, measure = "E1/E2 = 1e-6, 1e6, nu = 0.3", "W with the bodies exchanged"
    yield Case(FE, "stiffness ratio, coupled", tried, measure, 5e-3, each(exchanged, (1e-6, 1e6)))
    yield stated("flat face", "b/a = 1e-9 ... 1 - 1e-9", fe_flat_face, (1e-9, 1e-6, 1e-3, 0.9, 0.999, 1 - 1e-6, 1 - 1e-9))
    radii = of_loop(lambda radius: {"profile": Hertz(radius=radius)})
    yield stated("a/R", "R = 1e-9 ... 1e6, a/R from 7e4 to 2e-3", radii, (1e-9, 1e-6, 1e-3, 1.0, 1e6))
    yield stated("sharp tips", "h as x^1.1 ... x^1.9, a rounded wedge", of_tip, (1.1, 1.3, 1.5, 1.9, 0.0))
    far = [*changes("far_radius", 2.0, 1000.0), *changes("growth", 0.05, 1.0)]
    yield stated("a/L and grading", "L = 2 a and 1000 a, growth 0.05 and 1", changed_mesh, far)
    cut = [{"element_size": 0.25, "edge_element_size": edge} for edge in (0.25, 1 / 128)]
    yield stated("coarse, and graded 1 : 32", "h = a/4; a/4 and a/128 at the edges", changed_mesh, cut)
    yield stated("linear elements", "coarse", changed_mesh, changes("order", 1))
    yield stated("mesh ratios", "upper over lower 1/4, 2, 4, 20", changed_mesh, changes("upper_ratio", 0.25, 2.0, 4.0, 20.0))
    beyond = [{"upper_ratio": 21.0}, {"far_radius": 1.0}, {"growth": 2.0}, {"element_size": 1.0}]
    yield refused("beyond the mesher's range", "ratio 21, L = a, growth 2, h = a", refused_mesh, beyond)
    yield stated("step sizes", "4, 8, 1000 increments a cycle", of_steps, (4, 8, 1000))
    yield refused("too few or many steps", "1 and 10^6 a cycle", of_steps, (1, 1_000_000))
    # Two lines on a mesh of 41 contact nodes, nine of 12,500 increments each on one of 25.
    trials = [("10^4", partial(many_steps, 1, 10_000, ROUGH)), ("10^5", partial(many_steps, 8, 12_500, COARSEST))]
    measure = "p, q, slip at the ends of lines and W, against 16 increments a line; laws, energy balance among them"
    yield Case(FE, "many increments", "10^4 a line, 10^5 in all, Q to and fro", measure, 1e-9, lambda: trials)
    tangents = of_load(lambda beyond: ellipse(2, 1, 0.05, 0.5 * (1 + beyond), 0))
    yield stated(
        "tangency within rounding", "dQ/dP = f (1 + e), e = -1e-12 ... 1e-12", tangents, (-1e-12, -1e-15, 0.0, 1e-15, 1e-12)
    )
    tried = "30 triangles a body squeezed to {} of their height"
    measure = "p, q in L2 and W, against the half-plane engine"
    slivers = each(with_slivers, (1e-2, 1e-4, 1e-6), "heights times {:g}")
    yield Case(FE, "slivers", tried.format("1e-2 ... 1e-6"), measure, STATED, slivers)
    yield refused("slivers next to rounding", tried.format("1e-8 ... 1e-14"), with_slivers, (1e-8, 1e-10, 1e-12, 1e-14))
    tried = "lower body a block, 1e6 a wide and a high, 4 a wide and 1e-4 a high, and between"
    blocks = each(on_block, [(1e3, 1.0), (1e6, 1.0), (4.0, 1e-2), (4.0, 1e-4)], "{:g} a by {:g} a")
    yield Case(FE, "bodies of absurd proportions", tried, "largest p, W, against elements half as long", STATED, blocks)
    tried = "lower body a block, 4 a wide, 4e3 a and 4e6 a high"
    yield refused("bodies like needles", tried, on_block, [(4.0, 4e3), (4.0, 4e6)])


def cases() -> Iterator[Case]:
    """Both engines' cases."""
    yield from half_plane_cases()
    yield from fe_cases()


HEAD = (
    "Written by `make stress` and by nothing else. Each case ends in a right answer, in one whose own notes state its error, or in "
    "a refusal of one sentence (quoted). An error above the limit of which the answer says nothing is broken, and so is a warning. "
    "The column “worst” has the worst of all trials that were answered, those with notes among them. The finite elements run on "
    "coarse meshes (`MeshSettings.coarse()`) unless the case says otherwise. The errors are: p in L2 over ‖p‖, q over f ‖p‖, at "
    "the worst of sixteen instants of the last revolution with more than 0.3 of the largest load, W over W; for W the error in "
    "A f² P² stands beside it, P being the largest load. Their limit is 5 % for each: a few times what a coarse mesh promises of "
    "the shear."
)


def page(found: Mapping[str, Outcome]) -> str:
    """The tables of docs/stress.md."""
    lines = ["# Numerical stress tests", "", HEAD, ""]
    for engine in (HALF_PLANE, FE):
        cells = []
        for case in (case for case in cases() if case.engine == engine and case.name in found):
            one = found[case.name]
            worst = _values(one.worst) + (f" ({_values(one.shown)})" if one.shown else "")
            cells.append(
                (case.what, case.tried, case.measure, worst, f"{case.limit:.0e}" if one.worst else "", one.verdict, one.day)
            )
        lines += [f"## {engine}", "", *markdown("case | tried | measure | worst | limit | verdict | run", cells), ""]
    return "\n".join(lines)


def main(words: list[str]) -> int:
    """Run the cases that are asked for, all where none is; write the page."""
    known = {case.name: case for case in cases()}
    for name, case in known.items():
        if words == ["--pages"] or (words and not any(word in name for word in words)):
            continue
        found = outcome(case)
        write_json(KEPT, kept_json(KEPT) | {name: asdict(found)})
        print(f"{found.seconds:6.1f} s  {name}: {_values(found.worst)}  {found.verdict}", flush=True)
    before = {name: Outcome(**found) for name, found in kept_json(KEPT).items() if name in known}
    PAGE.write_text(page(before), encoding="utf-8")
    broken, missing = sum(bool(one.broken) for one in before.values()), [name for name in known if name not in before]
    print(f"docs/stress.md: {len(before)} cases, {broken} broken, {sum(one.seconds for one in before.values()):.0f} s")
    if missing:
        print(f"not run yet: {'; '.join(missing)}")
    return 1 if broken or missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
