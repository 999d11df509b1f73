"""Numerical stress: what both engines do at the ends of what a scene may ask, written to
docs/stress.md (a line a case) and docs/stress.csv (all of it).

    make stress                                    (python benchmarks/stress.py, ten minutes)
    python benchmarks/stress.py "flat face" ...    (only cases whose names hold one of these; the
                                                   others stay as found)
    python benchmarks/stress.py --pages            (none: the page from stress.json)

A case is a list of trials. A trial gives an error, to be at most the limit, or is refused by
InputError or ConvergenceError; anything else, a warning included, breaks the case.
"""

from __future__ import annotations

import csv
import functools
import io
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import mpmath
import numpy as np
import regress_truth
from claims import ROOT, markdown, measure
from half_plane import PROFILES, batch, like, table_of_ellipses

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
)
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import contact_of

PAGE = ROOT / "docs" / "stress.md"
TABLE = ROOT / "docs" / "stress.csv"
STORE = Path(__file__).with_suffix(".json")
HALF_PLANE = "Half-plane engine"
FE = "Finite elements"
LOOP = (3.0, 1.0, 0.2, 0.8, 70.0)
COARSE = MeshSettings.coarse()
FEW = SolverSettings(steps_per_cycle=32)
ROUGH = replace(COARSE, element_size=1 / 4, edge_element_size=1 / 8)
# Limit of the errors of p, q and W, each for itself: above it the solver has to say so. A few times
# what a coarse mesh promises of the shear (about 1 % in L2): what a reader of a first look takes
# for good if nothing is said.
STATED = 0.05
# Half-width a of `LOOP` at its largest load on half-planes, in the scene's lengths; above which a
# law is broken.
HALF_WIDTH = 22.6
BROKEN = 1e-7


class Found(NamedTuple):
    """What a trial measured: errors held against the limit, the answer's own notes, values that are
    only shown.
    """

    errors: Mapping[str, float]
    notes: tuple[str, ...] = ()
    shown: Mapping[str, float] = {}


@dataclass(frozen=True)
class Case:
    """Trials of one kind.

    Attributes
    ----------
    engine, what, tried, measure, limit : who, which end of the range, the values; what the error is
    of, and how large it may be function, values : what gives the errors or refuses, and its
    arguments, one or a tuple for each trial
    words : name of a trial, from its arguments
    refuses : whether each of the trials has to end in a sentence
    may_state : whether an error above the limit passes if the answer says so: it is shown with its
        note
    """

    engine: str
    what: str
    tried: str
    measure: str
    limit: float
    function: Callable[..., float | Found]
    values: Iterable[Any]
    words: str = "{}"
    refuses: bool = False
    may_state: bool = False


@dataclass
class Outcome:
    """What became of a case: worst errors of the trials that were answered, what was stated, who
    refused, what broke.
    """

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
        words = []
        if self.right:
            words.append(f"right ({self.right})" if self.told else "right")
        words += [f"stated: {sentence}" for sentence in self.told]
        words += [f"refused: “{sentence}”" for sentence in self.refused]
        return "; ".join(words)

    def count(self, case: Case, name: str, outcome_of_case: float | Found) -> None:
        """One trial that was answered: right, in error and stated, or wrong and silent."""
        errors, notes, shown_values = (
            outcome_of_case
            if isinstance(outcome_of_case, Found)
            else Found({"": float(outcome_of_case)})
        )
        for target, source in ((self.worst, errors), (self.shown, shown_values)):
            target |= {
                key: float(np.maximum(target.get(key, 0.0), value)) for key, value in source.items()
            }
        off = {key: value for key, value in errors.items() if not value <= case.limit}
        values = _values({**off, **(shown_values if "W" in off else {})})
        if not off:
            self.right += 1
        elif (
            case.may_state and notes and np.isfinite([v for k, v in off.items() if k != "W"]).all()
        ):
            self.told.append(f"{name}: {values}, with the note “{'” and “'.join(notes)}”")
        else:
            self.broken.append(f"{name}: {'wrong, silent: ' * case.may_state}{values}")


def _values(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.1e}".strip() for name, value in values.items())


def outcome(case: Case) -> dict[str, Any]:
    """Every trial of a case, warnings being errors."""
    outcome_of_case = Outcome(day=datetime.now(UTC).date().isoformat())
    started = time.perf_counter()
    for value in case.values:
        arguments = value if isinstance(value, tuple) else (value,)
        name = case.words.format(*arguments)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                outcome_of_case.count(case, name, case.function(*arguments))
        except (InputError, ConvergenceError) as reason:
            sentence = f"{reason}".splitlines()[0]
            outcome_of_case.refused += [] if sentence in outcome_of_case.refused else [sentence]
            outcome_of_case.broken += [] if case.refuses else [f"{name}: refused, {reason}"]
        # a traceback is what is looked for: it is counted and shown
        except Exception as reason:  # noqa: BLE001
            outcome_of_case.broken.append(f"{name}: {type(reason).__name__}: {reason}")
    if case.refuses and outcome_of_case.worst:
        outcome_of_case.broken.append("a trial was answered")
    outcome_of_case.seconds = time.perf_counter() - started
    print(f"{_values(outcome_of_case.worst)}  {outcome_of_case.verdict}", flush=True)
    return asdict(outcome_of_case)


# ------------------------------------------------------------------------------------------- scenes
def scene_of(
    load: Any,
    friction: float = 0.5,
    profile: Profile | None = None,
    material: Materials | None = None,
) -> Scene:
    """Hertz of radius 100 and E* = 1 where nothing else is said."""
    profile = profile or Hertz(radius=100.0)
    material = material or like(1.0)
    return Scene(
        name="stress",
        material=material,
        profile=profile,
        friction=Friction(coefficient=friction),
        load=load,
    )


def ellipse(p0: float, p1: float, q0: float, q1: float, phase: float) -> EllipseLoad:
    """P0, P1, Q0, Q1 and the phase in degrees."""
    loads = {
        "mean_normal_load": p0,
        "normal_amplitude": p1,
        "mean_tangential_load": q0,
        "tangential_amplitude": q1,
    }
    return EllipseLoad(**loads, phase_degrees=phase)


def to_and_fro(share: float, friction: float) -> PolygonLoad:
    """Q between +-share f P at constant P = 1."""
    return PolygonLoad(
        initial_loading=((1.0, 0.0),), cycle=((1.0, share * friction), (1.0, -share * friction))
    )


def in_proportion(f: float) -> Scene:
    """A loop whose Q is in proportion to f."""
    return scene_of(ellipse(3, 1, 0.4 * f, 1.6 * f, 70), f)


def flat_face(part: float) -> Scene:
    """A flat face with b/a = part, a = 1 at the largest load."""
    profile = FlatRounded(radius=100.0, flat_half_length=part)
    load = float(contact_of(profile, like(1.0)).load(1.0))
    return scene_of(ellipse(0.75 * load, 0.25 * load, 0.05 * load, 0.2 * load, 70), 0.5, profile)


def in_units(length: float, stress: float, profile: Profile) -> Scene:
    """`LOOP` in units of length and stress."""
    return scene_of(
        ellipse(*(np.array(LOOP[:4]) * length * stress), LOOP[4]), 0.5, profile, like(stress)
    )


UNITS = [(length, stress) for stress in (1e-12, 1e12) for length in (1e-12, 1e12)]


def apart(
    answer: ContactSolution, reference: ContactSolution, length: float, stress: float, *names: str
) -> float:
    """Worst change of any of these fields of the other in units of length and stress, over its
    largest value.
    """
    units = {
        "pressure": stress,
        "shear": stress,
        "dissipation_density": length * stress,
        "dissipation": length**2 * stress,
    }
    pairs = [
        (np.asarray(getattr(reference, n)) / units.get(n, length), np.asarray(getattr(answer, n)))
        for n in names
    ]
    return max(
        float(np.nanmax(np.abs(scaled - plain)) / np.nanmax(np.abs(plain)))
        for scaled, plain in pairs
    )


def broken_by(answer: ContactSolution) -> float:
    """The worst certificate."""
    return max(float(np.max(values)) for values in answer.record.certificates.values())


def work_of(scene: Scene) -> float:
    """W by the half-plane engine."""
    return float(semi_analytic.solve(scene, x=[0.0], fields=("dissipation",)).dissipation)


# -------------------------------------------------------------------------------- half-plane engine
def of_mindlin(share: float, friction: float, over_stated: bool = False) -> float:
    """Relative error of W; over what the engine states of it with `over_stated`."""
    answer = semi_analytic.solve(
        scene_of(to_and_fro(share, friction), friction), x=[0.0], fields=("dissipation",)
    )
    with mpmath.workdps(60):
        exact = regress_truth.mindlin(
            min(mpmath.mpf(share * friction) / mpmath.mpf(friction), 1), mpmath.mpf(friction)
        )
    error = abs(float(answer.dissipation / exact - 1))
    return error / answer.record.errors["dissipation"] if over_stated else error


def theory_in_units(kind: str, length: float, stress: float) -> float:
    x = np.linspace(-2.6, 2.6, 41)
    in_millimetres, in_other_units = (
        semi_analytic.solve(in_units(u, s, PROFILES[kind](u)), x=x * u)
        for u, s in ((1.0, 1.0), (length, stress))
    )
    moves = (
        "slip",
        "tangential_displacement",
        "normal_approach",
        "contact_half_width",
        "stick_half_width",
    )
    worst = apart(
        in_millimetres,
        in_other_units,
        length,
        stress,
        "pressure",
        "shear",
        "dissipation_density",
        "dissipation",
        *moves,
    )
    return worst if np.array_equal(in_millimetres.state, in_other_units.state) else float("nan")


def wave(count: int, noise: float = 0.0) -> np.ndarray:
    """Rows of a wave of 400 rows a period, with noise, clipped inside the cone."""
    rng = np.random.default_rng(1)
    phase = 2 * np.pi * np.arange(count) / 400
    normal = 3 + np.cos(phase) + noise * rng.standard_normal(count)
    force = 0.8 * np.cos(phase - 1.2) + noise * rng.standard_normal(count)
    return np.column_stack(
        [np.arange(count), normal, np.clip(force, -0.45 * normal, 0.45 * normal)]
    )


def of_rows(count: int, noise: float, kind: str) -> float:
    """Worst mismatch of M(P) = Q and the cone over all rows of a wave; that repeats, or is held for
    a while.
    """
    rows = wave(count, noise)
    repeats = kind == "again and again"
    if repeats:
        rows[-1, 1:] = rows[0, 1:]
    elif kind == "with repeats":
        rows[1000:300_000, 1:] = rows[1000, 1:]
    answer = semi_analytic.solve(
        scene_of(TimeSeriesLoad(rows=rows, repeats=repeats)), x=[0.0], fields=("dissipation",)
    )
    return (
        broken_by(answer)
        if np.isfinite(answer.dissipation) and answer.dissipation > 0
        else float("nan")
    )


# ---------------------------------------------------------------------------------- finite elements
def against_theory(
    scene: Scene, mesh: MeshSettings = COARSE, settings: SolverSettings = FEW
) -> Found:
    """Errors of p over ||p||, of q over f ||p||, in L2 at the worst of 16 instants of the last
    revolution with more than 0.3 of the largest load; of W over W (infinite where nothing should
    slip), with that in A f^2 P^2 shown. NaN where a law is broken.
    """
    answer = halfplane_fe.solve(scene, mesh, settings)
    period = scene.load.path().period
    start = answer.time[-1] - period * (1 - 1e-9) if period is not None else -np.inf
    loaded = np.flatnonzero(
        (answer.normal_load > 0.3 * answer.normal_load.max()) & (answer.time > start)
    )
    chosen = loaded[np.unique(np.linspace(0, len(loaded) - 1, 16).astype(int))]
    exact = semi_analytic.solve(
        scene, x=answer.x, time=answer.time[chosen], fields=("pressure", "shear")
    )

    def l2(values: np.ndarray) -> np.ndarray:
        return np.sqrt(values**2 @ answer.face_lengths)

    work = work_of(scene)
    size = l2(exact.pressure)
    friction = scene.friction.coefficient
    unit = 2 / composite_modulus(scene.material) * (friction * answer.normal_load.max()) ** 2
    off = abs(answer.dissipation - work)
    error_of_work = off / work if work else np.inf
    if not off:
        error_of_work = 0.0
    errors = {
        "p": float(np.max(l2(answer.pressure[chosen] - exact.pressure) / size)),
        "q": float(np.max(l2(answer.shear[chosen] - exact.shear) / (friction * size))),
        "W": error_of_work,
    }
    # Equilibrium is over P of the instant, of which rounding of the largest load is a share.
    rounding = (
        4
        * np.finfo(float).eps
        * answer.normal_load.max()
        / answer.normal_load[answer.normal_load > 0].min()
    )
    if broken_by(answer) > BROKEN + rounding:
        errors = dict.fromkeys(errors, float("nan"))
    return Found(errors, answer.record.notes, {"W in A f² P²": off / unit})


@functools.cache
def fe_in(length: float, stress: float) -> ContactSolution:
    return halfplane_fe.solve(in_units(length, stress, Hertz(radius=length)), COARSE, FEW)


def fe_in_units(length: float, stress: float) -> float:
    names = ("pressure", "shear", "slip", "contact_edges", "dissipation_density")
    return apart(fe_in(1.0, 1.0), fe_in(length, stress), length, stress, *names)


def pair(ratio: float, upper: float, lower: float) -> Materials:
    """E1/E2 = ratio with the two Poisson ratios, and E* = 1."""
    soft = (1 - upper**2) / ratio + (1 - lower**2)
    stiff = Elastic(young_modulus=ratio * soft, poisson_ratio=upper)
    return Materials(upper=stiff, lower=Elastic(young_modulus=soft, poisson_ratio=lower))


def exchanged(ratio: float) -> float:
    """W with the bodies exchanged, which is the same scene seen from below."""
    materials = pair(ratio, 0.3, 0.3)
    of_both_orders = materials, Materials(upper=materials.lower, lower=materials.upper)
    works = [
        halfplane_fe.solve(scene_of(ellipse(*LOOP), material=material), COARSE, FEW).dissipation
        for material in of_both_orders
    ]
    return abs(works[1] / works[0] - 1)


def many_steps(corners: int, count: int, mesh: MeshSettings = ROUGH) -> Found:
    """P, then Q to and fro between 0.6 and -0.6 f P over so many lines, `count` increments each:
    against 16 each, and the laws.
    """
    lines = tuple((1.0, 0.3 * (-1) ** number) for number in range(corners))
    scene = scene_of(PolygonLoad(initial_loading=((1.0, 0.0), *lines)))

    def solved(increments: int) -> ContactSolution:
        return halfplane_fe.solve(
            scene, mesh, SolverSettings(steps_per_cycle=8 * increments, step_tolerance=np.inf)
        )

    with_many = solved(count)
    with_few = solved(16)
    if len(with_many.time) + with_many.work.skipped.get("instants", (0,))[0] < count * (
        corners + 1
    ):
        return Found({"increments missing": float("nan")})
    rows, rows_of_few = (
        np.searchsorted(answer.time, np.arange(1.0, corners + 1.5) - 1e-9)
        for answer in (with_many, with_few)
    )
    off = {
        "W": abs(with_many.dissipation / with_few.dissipation - 1),
        "laws": max(broken_by(with_many), broken_by(with_few)),
    }
    for symbol, name in (("p", "pressure"), ("q", "shear"), ("slip", "slip")):
        values = getattr(with_many, name)[rows]
        values_of_few = getattr(with_few, name)[rows_of_few]
        off[symbol] = float(np.max(np.abs(values - values_of_few)) / np.max(np.abs(values_of_few)))
    return Found(off)


def squeezed(body: BodyMesh, share: float, count: int = 30) -> BodyMesh:
    """The body with `count` slivers: inner nodes, far and near, moved towards the opposite side of
    one of their triangles, of whose distance they keep that `share`.
    """
    mesh = body.mesh
    places = mesh.doflocs.copy()
    corners = mesh.t

    def areas(at: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        (x0, y0), (x1, y1), (x2, y2) = (at[:, row] for row in triangles)
        return (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)

    boundary_nodes = set(mesh.facets[:, mesh.boundary_facets()].ravel().tolist())
    moved: list[int] = []
    for number in np.random.default_rng(0).permutation(corners.shape[1]):
        node, *side = corners[:, number].tolist()
        if len(moved) == count or not boundary_nodes.isdisjoint((node, *side)):
            continue
        star = corners[:, np.any(corners == node, axis=0)]
        trial = places.copy()
        middle = np.mean(places[:, side], axis=1)
        trial[:, node] = middle + share * (places[:, node] - middle)
        if np.all(areas(trial, star) * areas(places, star) > 0):
            places = trial
            moved = [*moved, node]
            boundary_nodes.update(star.ravel().tolist())
    bent = np.flatnonzero(np.isin(mesh.facets, moved).any(axis=0))
    places[:, mesh.dofs.facet_dofs[0, bent]] = np.mean(places[:, mesh.facets[:, bent]], axis=1)
    if len(moved) < count:
        raise ValueError(f"only {len(moved)} nodes can be moved")
    squeezed_mesh = replace(mesh, doflocs=places)
    return replace(body, mesh=squeezed_mesh, quality=mesh_quality(squeezed_mesh, 1.0))


def aspect(*bodies: BodyMesh) -> float:
    """Length over height of the worst triangle."""
    return max(float(1 / np.tan(np.radians(body.quality["least_angle"]))) for body in bodies)


def with_slivers(share: float) -> Found:
    """Against the half-plane engine, both bodies squeezed; the worst aspect stands beside the
    errors.
    """
    bodies: list[BodyMesh] = []

    def build(*arguments: Any) -> BodyMesh:
        bodies.append(squeezed(meshes.build(*arguments), share))
        return bodies[-1]

    with mock.patch("halfplane_fe.interface.build", build):
        errors = against_theory(scene_of(ellipse(*LOOP)))
    return errors._replace(shown={**errors.shown, "aspect": aspect(*bodies)})


def on_block(width: float, height: float) -> Found:
    """Largest p and W on a block, sizes over the half-width, against elements half as long; NaN
    where a law is broken.
    """
    scene = scene_of(ellipse(*LOOP)).vary(
        bodies=Bodies(lower=Block(width=width * HALF_WIDTH, height=height * HALF_WIDTH))
    )
    finer = replace(
        COARSE, element_size=COARSE.element_size / 2, edge_element_size=COARSE.edge_element_size / 2
    )
    answer, better = (halfplane_fe.solve(scene, mesh, FEW) for mesh in (COARSE, finer))
    p = answer.pressure.max() / better.pressure.max()
    w = answer.dissipation / better.dissipation
    off = {"p": abs(float(p) - 1), "W": abs(w - 1)}
    if max(broken_by(answer), broken_by(better)) > BROKEN:
        off = dict.fromkeys(off, float("nan"))
    return Found(off, answer.record.notes, {"aspect": aspect(answer.bodies[0])})


# -------------------------------------------------------------------------------------------- cases
def half_plane_cases() -> Iterator[Case]:
    case = partial(Case, HALF_PLANE)
    exact = "W against the closed form"
    units = [(kind, *unit) for kind in PROFILES for unit in UNITS]
    tried = "lengths and stresses times 1e-12 and 1e12, eight kinds of profile"
    measure = "any field over its largest value, any state"
    yield case(
        "units", tried, measure, 1e-12, theory_in_units, units, "{}, lengths {:g}, stresses {:g}"
    )
    shares = [(share, friction) for friction in (1e-6, 1e-3, 1.0, 100.0) for share in (0.3, 0.9)]
    yield case(
        "friction",
        "f = 1e-6, 1e-3, 1, 100; Q to 0.3 and 0.9 f P",
        exact,
        1e-12,
        of_mindlin,
        shares,
        "{:g} f P, f = {:g}",
    )

    def proportion(f: float) -> float:
        return abs(work_of(in_proportion(f)) / f**2 / work_of(in_proportion(1.0)) - 1)

    measure = "W/f² against that of f = 1"
    yield case(
        "friction, ellipse",
        "f = 1e-6 to 100, Q in proportion",
        measure,
        1e-12,
        proportion,
        (1e-6, 1e-3, 100.0),
    )
    sliding = [(1 - left, 0.5) for left in (1e-6, 1e-9, 1e-12, 1e-15, 0.0)]
    yield case(
        "near gross sliding",
        "1e-6 to 1e-15 of f P left, and none",
        exact,
        1e-12,
        of_mindlin,
        sliding,
        "{!r} f P",
    )
    tiny = [(10.0**-power, 0.3, True) for power in range(4, 15)]
    measure = "error of W over the error that is stated"
    yield case(
        "next to no slip", "Q to 1e-4 ... 1e-14 of f P, a polygon", measure, 1.0, of_mindlin, tiny
    )

    def hard(row: int) -> float:
        ellipse_of_row = table_of_ellipses(extremes=True)[row]
        return abs(batch(ellipse_of_row) / float(ellipse_of_row["dissipation"]) - 1)

    tried = (
        "22 stored ones: slip of 1e-9 of f P, 1 - 1e-12 of gross sliding, P1/P0 = 1 - 1e-9, within"
        " 1e-9 of phase 0 or pi"
    )
    yield case(
        "ellipses", tried, "W of the batch against 30 digits", 1e-10, hard, range(22), "row {}"
    )
    rows = [(100_001, 0.0, "smooth"), (1_000_001, 0.0, "smooth"), (1_000_001, 0.01, "noisy")]
    rows += [(1_000_001, 0.0, "with repeats"), (100_001, 0.01, "again and again")]
    tried = "10^5 and 10^6 rows, smooth, noisy, with repeats, again and again"
    yield case(
        "long histories",
        tried,
        "cone and M(P) = Q, over f P",
        1e-12,
        of_rows,
        rows,
        "{} rows, noise {:g}, {}",
    )


def fe_cases() -> Iterator[Case]:
    claim = "p, q in L2 and W, against the half-plane engine"

    def stated(what: str, tried: str, scene: Callable[[Any], Any], *values: Any) -> Case:
        """`scene` gives a scene, or the arguments of against_theory."""

        def function(value: Any) -> Found:
            scene_of_value = scene(value)
            return against_theory(
                *(scene_of_value if isinstance(scene_of_value, tuple) else (scene_of_value,))
            )

        return Case(FE, what, tried, claim, STATED, function, values, may_state=True)

    def refused(what: str, tried: str, function: Callable[..., Any], *values: Any) -> Case:
        return Case(FE, what, tried, "refused", 0.0, function, values, refuses=True)

    def loop(**changes: Any) -> Scene:
        return scene_of(ellipse(*LOOP), **changes)

    def on_mesh(change: dict[str, Any]) -> tuple[Scene, MeshSettings]:
        return loop(), replace(COARSE, **change)

    def in_steps(count: int) -> tuple[Scene, MeshSettings, SolverSettings]:
        return loop(), COARSE, SolverSettings(steps_per_cycle=count)

    def uncoupled(ratio: float) -> Scene:
        # The soft one incompressible: beta next to 0.
        return loop(material=pair(ratio, *((0.4999, 0.2) if ratio < 1 else (0.2, 0.4999))))

    def tip(exponent: float) -> Scene:
        sharp = (
            PowerLaw(exponent=exponent, length=1.0, rise=0.5)
            if exponent
            else Wedge(tip_radius=1.0, tip_half_length=0.1)
        )
        return loop(profile=sharp)

    def sliding(left: float) -> Scene:
        return scene_of(to_and_fro(1 - left, 0.5))

    def little(part: float) -> Scene:
        return scene_of(ellipse(1, 1 - part, 0, 0.2 * part, 90))

    def changes(name: str, *values: float) -> list[dict[str, float]]:
        return [{name: value} for value in values]

    tried = "lengths and stresses times 1e-12 and 1e12"
    measure = "any field over its largest value"
    yield Case(FE, "units", tried, measure, 1e-9, fe_in_units, UNITS, "lengths {:g}, stresses {:g}")
    yield stated(
        "friction", "f = 1e-6, 1e-3, 1, 100, Q in proportion", in_proportion, 1e-6, 1e-3, 1.0, 100.0
    )
    yield stated(
        "near gross sliding", "1e-3 ... 1e-13 of f P left", sliding, 1e-3, 1e-6, 1e-9, 1e-12, 1e-13
    )
    yield refused(
        "at gross sliding",
        "1e-15 of f P left, and none",
        lambda left: against_theory(sliding(left)),
        1e-15,
        0.0,
    )
    shares = (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-6, 1e-12)
    tried = "Q to 0.3 ... 1e-12 of f P: 5 to 2e-11 elements"
    yield stated(
        "slip zones smaller than an element",
        tried,
        lambda share: scene_of(to_and_fro(share, 0.5)),
        *shares,
    )
    yield stated("next to no load", "P_min/P0 = 1e-3, 1e-6, 1e-9", little, 1e-3, 1e-6, 1e-9)
    yield refused(
        "less than rounding of the load",
        "P_min/P0 = 1e-12",
        lambda part: against_theory(little(part)),
        1e-12,
    )
    nus = (-0.9, 0.0, 0.4999, 0.499999)
    yield stated(
        "Poisson's ratio",
        "nu = -0.9, 0, 0.4999, 0.499999",
        lambda nu: loop(material=like(1.0, nu)),
        *nus,
    )
    tried = "E1/E2 = 1e-6 ... 1e6, the soft body incompressible"
    yield stated("stiffness ratio, uncoupled", tried, uncoupled, 1e-6, 1e-3, 1e3, 1e6)
    tried = "E1/E2 = 1e-6, 1e6, nu = 0.3"
    measure = "W with the bodies exchanged"
    yield Case(FE, "stiffness ratio, coupled", tried, measure, 5e-3, exchanged, (1e-6, 1e6))
    parts = (1e-9, 1e-6, 1e-3, 0.9, 0.999, 1 - 1e-6, 1 - 1e-9)
    yield stated("flat face", "b/a = 1e-9 ... 1 - 1e-9", flat_face, *parts)
    radii = (1e-9, 1e-6, 1e-3, 1.0, 1e6)
    yield stated(
        "a/R",
        "R = 1e-9 ... 1e6, a/R from 7e4 to 2e-3",
        lambda radius: loop(profile=Hertz(radius=radius)),
        *radii,
    )
    yield stated(
        "sharp tips", "h as x^1.1 ... x^1.9, a rounded wedge", tip, 1.1, 1.3, 1.5, 1.9, 0.0
    )
    far = [*changes("far_radius", 2.0, 1000.0), *changes("growth", 0.05, 1.0)]
    yield stated("a/L and grading", "L = 2 a and 1000 a, growth 0.05 and 1", on_mesh, *far)
    cut = [{"element_size": 0.25, "edge_element_size": edge} for edge in (0.25, 1 / 128)]
    yield stated("coarse, and graded 1 : 32", "h = a/4; a/4 and a/128 at the edges", on_mesh, *cut)
    yield stated("linear elements", "coarse", on_mesh, {"order": 1})
    yield stated(
        "mesh ratios",
        "upper over lower 1/4, 2, 4, 20",
        on_mesh,
        *changes("upper_ratio", 0.25, 2.0, 4.0, 20.0),
    )
    beyond = [{"upper_ratio": 21.0}, {"far_radius": 1.0}, {"growth": 2.0}, {"element_size": 1.0}]
    yield refused("beyond the mesher's range", "ratio 21, L = a, growth 2, h = a", on_mesh, *beyond)
    yield stated("step sizes", "4, 8, 1000 increments a cycle", in_steps, 4, 8, 1000)
    yield refused("too few or many steps", "1 and 10^6 a cycle", in_steps, 1, 1_000_000)
    # Two lines on a mesh of 41 contact nodes, nine of 12,500 increments each on one of 25.
    trials = [(1, 10_000, ROUGH), (8, 12_500, replace(ROUGH, edge_element_size=1 / 4))]
    measure = (
        "p, q, slip at the ends of lines and W, against 16 increments a line; laws, energy balance"
        " among them"
    )
    yield Case(
        FE,
        "many increments",
        "10^4 a line, 10^5 in all, Q to and fro",
        measure,
        1e-9,
        many_steps,
        trials,
        "{1} a line",
    )
    tangents = (-1e-12, -1e-15, 0.0, 1e-15, 1e-12)
    tried = "dQ/dP = f (1 + e), e = -1e-12 ... 1e-12"
    yield stated(
        "tangency within rounding",
        tried,
        lambda e: scene_of(ellipse(2, 1, 0.05, 0.5 * (1 + e), 0)),
        *tangents,
    )
    tried = "30 triangles a body squeezed to {} of their height"
    heights = (1e-2, 1e-4, 1e-6, 1e-8)
    yield Case(
        FE,
        "slivers",
        tried.format("1e-2 ... 1e-8"),
        claim,
        STATED,
        with_slivers,
        heights,
        "heights times {:g}",
    )
    yield refused(
        "slivers next to rounding",
        tried.format("1e-10 ... 1e-14"),
        with_slivers,
        1e-10,
        1e-12,
        1e-14,
    )
    tried = "lower body a block, 1e6 a wide and a high, 4 a wide and 1e-4 a high, and between"
    sizes = [
        (1e3, 1.0),
        (1e6, 1.0),
        (4.0, 1e-2),
        (4.0, 1e-4),
    ]
    measure = "largest p, W, against elements half as long"
    yield Case(
        FE,
        "bodies of absurd proportions",
        tried,
        measure,
        STATED,
        on_block,
        sizes,
        "{:g} a by {:g} a",
    )
    tried = "lower body a block, 4 a wide, 4e3 a and 4e6 a high"
    yield refused("bodies like needles", tried, on_block, (4.0, 4e3), (4.0, 4e6))


def cases() -> dict[str, Case]:
    """Both engines' cases by name."""
    return {f"{case.engine}: {case.what}": case for case in (*half_plane_cases(), *fe_cases())}


HEAD = (
    "Written by `make stress`. Each trial of a case ends in a right answer, in one whose own notes"
    " state its error (“stated”), or in a refusal of one sentence. An error above the limit without"
    " a note is broken, and so is a warning. “Worst” is over all trials that were answered, those"
    " with notes among them. [stress.csv](stress.csv) has what was tried and measured in each case,"
    " the notes and the refusals."
)
HEAD_OF = {
    HALF_PLANE: "Errors of dissipation W, fields or laws, as the case's row in stress.csv states.",
    FE: (
        "Coarse meshes unless the case says otherwise. Errors: p over ‖p‖ and q over f ‖p‖ (L2,"
        " worst of sixteen instants), W over W (inf: theory has none); “abs.”: W over A f² P², P"
        " the largest load."
        f" The limit {STATED:.0%} is a few times what a coarse mesh promises of the shear."
    ),
}


def _worst(values: Mapping[str, float], shown: Mapping[str, float]) -> str:
    """Largest errors in the shortest form: `p 0.006, W 0.00023, abs. 5.8e-6`."""
    words = [f"{name} {_short(value)}".strip() for name, value in values.items()]
    if "W in A f² P²" in shown:
        words.append(f"abs. {_short(shown['W in A f² P²'])}")
    return ", ".join(words) or "–"


def _short(value: float) -> str:
    """Two digits, and no zero before an exponent: `0.29`, `5.8e-6`."""
    return f"{value:.2g}".replace("e-0", "e-").replace("e+0", "e")


def _verdict(outcome_of_case: Outcome) -> str:
    """The verdict in a word or two, with the number of trials where there is more than one kind."""
    if outcome_of_case.broken:
        return "**broken**"
    counts = {
        "right": outcome_of_case.right,
        "stated": len(outcome_of_case.told),
        "refused": len(outcome_of_case.refused),
    }
    kinds = {word: count for word, count in counts.items() if count}
    if len(kinds) == 1:
        return next(iter(kinds))
    return ", ".join(f"{count} {word}" for word, count in kinds.items())


def page(outcomes: Mapping[str, Outcome]) -> str:
    """The tables of docs/stress.md: a line a case."""
    known = cases()
    days = sorted({outcome_of_case.day for outcome_of_case in outcomes.values()})
    run = f"Run on {days[0]}" if len(days) == 1 else f"Run from {days[0]} to {days[-1]}"
    lines = ["# Numerical stress tests", "", f"{HEAD} {run}."]
    for engine, words in HEAD_OF.items():
        cells = []
        for name, case in known.items():
            if case.engine == engine and (one := outcomes.get(name)):
                limit = _short(case.limit) if one.worst else "–"
                cells.append((case.what, _worst(one.worst, one.shown), limit, _verdict(one)))
        table = markdown("case | worst | limit | verdict", cells)
        lines += ["", f"## {engine}", "", words, "", *table]
    return "\n".join(lines) + "\n"


def table_of_trials(outcomes: Mapping[str, Outcome]) -> str:
    """docs/stress.csv: what was tried and measured in each case, and every note and refusal."""
    written = io.StringIO()
    rows = csv.writer(written, lineterminator="\n")
    rows.writerow(["engine", "case", "tried", "measure", "worst", "limit", "verdict", "run"])
    for name, case in cases().items():
        one = outcomes.get(name)
        if one is None:
            continue
        worst = _values(one.worst) + (f" ({_values(one.shown)})" if one.shown else "")
        limit = f"{case.limit:.0e}" if one.worst else ""
        row = [case.engine, case.what, case.tried, case.measure, worst, limit, one.verdict, one.day]
        rows.writerow(row)
    return written.getvalue()


def main(words: list[str]) -> int:
    """Run the cases that are asked for, all where none is; write the page."""
    known = cases()
    stored = measure(STORE, {name: partial(outcome, case) for name, case in known.items()}, words)
    outcomes = {name: Outcome(**outcome_of_case) for name, outcome_of_case in stored.items()}
    PAGE.write_text(page(outcomes), encoding="utf-8")
    TABLE.write_text(table_of_trials(outcomes), encoding="utf-8")
    broken = sum(bool(outcome_of_case.broken) for outcome_of_case in outcomes.values())
    missing = [name for name in known if name not in outcomes]
    print(
        f"docs/stress.md: {len(outcomes)} cases, {broken} broken,"
        f" {sum(outcome_of_case.seconds for outcome_of_case in outcomes.values()):.0f} s"
    )
    if missing:
        print(f"not run yet: {'; '.join(missing)}")
    return 1 if broken or missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
