"""Does the stated uncertainty cover the known error, what does it cost, and which term does a
planted fault fall on?

    python benchmarks/covered.py values [COUNT] [SEED] [PRESET] [store]
                                                            every value of finite elements between
                                                            random half-planes, beside theory (30
                                                            scenes: four minutes of CPU)
    python benchmarks/covered.py bodies [COUNT] [SEED] [PRESET] [store]
                                                            the same of blocks, layers, pads,
                                                            cylinders, unlike bodies, bulk stress
                                                            and tilt, beside finer meshes; with
                                                            `store` the tables are kept for the
                                                            manual, benchmarks/covered.json
    python benchmarks/covered.py theory [COUNT] [SEED] [store]
                                                            what half-plane theory states of its own
                                                            errors, by closed forms, quadratures,
                                                            callables and grids (20 scenes each:
                                                            four minutes)
    python benchmarks/covered.py models [COUNT] [SEED]      W on random scenes, half of them blocks
                                                            (60 scenes: three minutes)
    python benchmarks/covered.py profiles [COUNT] [SEED]    noisy profilometer rows (200 cases);
                                                            exit code 1 below 95 %

Budgets: of half-planes the true error is known, the whole discrepancy; what the measured terms
leave unexplained must be covered by the stated uncertainty at least 95 times of 100, over the
metrics of the first table and the half-plane scenes of the library, on a mesh of twice the default
sizes (a/80 at the edges) with the default steps. Metrics that are nothing but round-off error,
|E| < 1e-11, are not counted: they would be covered for free.

Blame: faults are planted in either engine. A metric sees a fault where its value leaves the band of
the healthy run, |E| + u. Blamed is the largest term of the budget of the metric that left it
farthest; "model" is what no term accounts for: on half-planes there must be nothing, so one of the
engines is wrong. What the steps do to the dissipation is a metric by itself, and exact.
"""

from __future__ import annotations

import contextlib
import functools
import json
import math
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import must_fail
import numpy as np
from claims import Row
from random_bodies import judge_bodies
from random_scenes import LITTLE_SLIP, Tables, judge
from random_theory import judge_theory

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports import Comparison, compare
from reports.comparison.budget import (
    Budget,
    ErrorBudget,
    coarser_mesh_and_settings,
    error_budget,
    solve_refinements,
    theory_on_steps,
    values_without_step_error,
)
from reports.comparison.datum import effects_between
from reports.comparison.pairs import are_half_planes
from reports.page.writing import code_commit
from scenes import (
    ContactSolution,
    ConvergenceError,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    Scene,
    load_scene,
    scene_names,
)
from semi_analytic.profiles import contact_of

STORE = Path(__file__).parent / "covered.json"
COARSE = MeshSettings(element_size=1 / 12, edge_element_size=1 / 80)
MESH = MeshSettings()
STEPS = SolverSettings()
ROUNDED_OFF = 1e-11


# ------------------------------------------------------------------------------------------ budgets
def beside_theory(answer: ContactSolution) -> Comparison:
    """As `halfplane run` compares: theory on the points and instants of the result, and on the
    polygon of its increments.
    """
    reference = semi_analytic.solve(answer.scene, x=answer.x, time=answer.time)
    return compare(
        reference,
        answer,
        polygon_reference=theory_on_steps(answer),
        effects=effects_between(reference, answer),
    )


def plain(scene: Scene, mesh: MeshSettings, steps: SolverSettings = STEPS) -> Comparison:
    return beside_theory(halfplane_fe.solve(scene, mesh, steps))


def budget_of(
    comparison: Comparison, mesh: MeshSettings, steps: SolverSettings, spent: float
) -> ErrorBudget:
    """The budget of a run that took so many CPU seconds."""
    runs = solve_refinements(
        comparison, mesh, steps, lambda _name: contextlib.nullcontext(lambda *_progress: None)
    )
    return error_budget(comparison, runs, spent)


def budgeted(scene: Scene, mesh: MeshSettings = COARSE) -> ErrorBudget:
    """The plain run and its budget."""
    begun = time.process_time()
    comparison = plain(scene, mesh)
    return budget_of(comparison, mesh, STEPS, time.process_time() - begun)


def headlines(budget: ErrorBudget) -> list[Budget]:
    """What the first table shows and is more than round-off error."""
    return [
        term for term in budget.budgets if term.metric.headline and abs(term.error) > ROUNDED_OFF
    ]


def budgets() -> Iterator[Row]:
    """How often the stated uncertainty covers the known error, by metric and over all; its cost;
    real bodies.
    """
    scenes = {name: load_scene(name) for name in scene_names()}
    library = {name: budgeted(scene) for name, scene in scenes.items() if are_half_planes(scene)}
    pairs = [(name, term) for name, budget in library.items() for term in headlines(budget)]
    known = [(name, term) for name, term in pairs if term.is_covered is not None]
    claim = "budget: metrics that have no uncertainty, a term not being measured"
    yield Row(claim, len(pairs) - len(known), None, "left out below")
    missed = [f"{name} {term.metric.key}" for name, term in known if not term.is_covered]
    how = (
        f"{len(known) - len(missed)} of {len(known)} covered over {len(library)} scenes; not:"
        f" {', '.join(missed) or 'none'}"
    )
    yield Row(
        "budget: share not covered by the stated uncertainty", len(missed) / len(known), 0.05, how
    )
    thin = sum(abs(term.rest_of_error) > (term.uncertainty or 0.0) / 10 for _, term in known) / len(
        known
    )
    yield Row(
        "budget: ... by a tenth of it",
        thin,
        None,
        "the count can fail: no uncertainty is a blank cheque",
    )

    def sharpness(terms: list[Budget]) -> float:
        return float(np.median([(term.uncertainty or 0.0) / abs(term.error) for term in terms]))

    yield Row(
        "budget: u over |E|, median", sharpness([term for _, term in known]), None, "sharpness"
    )
    for key in dict.fromkeys(term.metric.key for _, term in known):
        of_metric = [term for _, term in known if term.metric.key == key]
        how = (
            f"{sum(bool(term.is_covered) for term in of_metric)} of {len(of_metric)};"
            f" u/|E| {sharpness(of_metric):.2g}"
            " in the median"
        )
        yield Row(
            f"budget: {key} not covered",
            sum(not term.is_covered for term in of_metric) / len(of_metric),
            None,
            how,
        )
    ratios = {name: budget.cpu_time_ratio for name, budget in library.items()}
    worst = max(ratios, key=ratios.__getitem__)
    yield Row(
        "budget, twice the default sizes: cost over the plain run, worst scene",
        ratios[worst],
        None,
        worst,
    )
    for name in ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper"):
        how = "CPU time; default mesh; every body condensed anew"
        yield Row(
            f"budget of {name}: cost over the plain run",
            budgeted(scenes[name], MESH).cpu_time_ratio,
            4.0,
            how,
        )
    # The far-field runs stand on 4 h: doubling L there and on the run's mesh.
    for label, factor in (("h", 1.0), ("4h", 4.0)):
        cut, _ = coarser_mesh_and_settings(COARSE, STEPS, factor)
        paper = scenes["hertz-paper"]
        near, far = (
            values_without_step_error(plain(paper, replace(cut, far_radius=radius)))
            for radius in (10.0, 20.0)
        )
        for key in ("dissipation", "peak_pressure"):
            claim = f"far field on {label}: {key} at L = 10 a less at 20 a"
            yield Row(
                claim,
                (near[key] or 0.0) - (far[key] or 0.0),
                None,
                "hertz-paper, scatter of meshing anew included",
            )
    yield real_bodies([scene for scene in scenes.values() if not scene.bodies.half_planes])


def real_bodies(scenes: list[Scene]) -> Row:
    """Real bodies have no known answer: the idealisation error +- u of the budget against the
    discrepancy on half the sizes.
    """
    covered = 0
    missed = []
    for scene in scenes:
        fine = values_without_step_error(plain(scene, MESH))
        for term in headlines(budgeted(scene)):
            if (truth := fine.get(term.metric.key)) is not None and term.uncertainty is not None:
                inside = abs(term.rest_of_error - truth) <= term.uncertainty
                covered = covered + inside
                missed = missed + ([] if inside else [f"{scene.name} {term.metric.key}"])
    how = (
        f"the discrepancy on half the sizes within u: {covered} of {covered + len(missed)}; not:"
        f" {', '.join(missed) or 'none'}"
    )
    return Row(
        "budget, real bodies: share not covered", len(missed) / (covered + len(missed)), 0.05, how
    )


# -------------------------------------------------------------------------------------------- blame
THEORY = semi_analytic.solve
STEP = "dissipation_step"
# Where the worst of single instants, or one of few, is too much a matter of chance to blame
# anything by.
LEFT_OUT = (
    "stick_edge",
    "state",
    "resultant",
    "energy",
    "tangential_displacement",
)


class Fault(NamedTuple):
    """What is planted, the term that shall be blamed, and how."""

    name: str
    blamed: str
    plant: Callable[[], must_fail.Planted] = contextlib.nullcontext
    settings: dict[str, Any] = {}  # noqa: RUF012 (never changed)
    mesh: MeshSettings = MESH


def theory(
    change: Callable[[Scene], Scene] = lambda scene: scene, sign: float = 1.0
) -> must_fail.Planted:
    """Half-plane theory answers another question, or with the wrong sign of q and U, and says that
    it is what was asked.
    """

    def planted(scene: Scene, *arguments: Any, **named: Any) -> ContactSolution:
        answer = THEORY(change(scene), *arguments, **named)
        turned = (
            {
                name: sign * getattr(answer, name)
                for name in ("shear", "tangential_displacement", "slip")
            }
            if sign < 0
            else {}
        )
        return replace(answer, scene=scene, **turned)

    return mock.patch.object(semi_analytic, "solve", planted)


def other_nu(scene: Scene) -> Scene:
    """Poisson's ratio of the upper body 0.4."""
    return scene.vary(
        material=Materials(
            upper=scene.material.upper.vary(poisson_ratio=0.4), lower=scene.material.lower
        )
    )


def rubbing(scene: Scene) -> Scene:
    """A coefficient of friction 1 % higher."""
    return scene.vary(friction=1.01 * scene.friction.coefficient)


def other_body() -> must_fail.Planted:
    """The FE model condenses an upper body of another Poisson's ratio."""
    make = must_fail.SOLVE.condensed_pair
    return mock.patch.object(
        must_fail.SOLVE,
        "condensed_pair",
        lambda scene, *arguments: make(other_nu(scene), *arguments),
    )


ROUGH = functools.partial(must_fail.rough, size=MESH.edge_element_size)
FAULTS = (
    Fault("FE: friction 1 % low", "model", lambda: must_fail.friction(0.99)),
    Fault("FE: history dropped", "model", lambda: must_fail.equilibrium(must_fail.forgetting)),
    # Friction then works the wrong way round: the residuals of the laws say so.
    Fault("FE: sign of Q flipped", "solver", lambda: must_fail.equilibrium(must_fail.turned_round)),
    Fault("FE: nu of the upper body 0.4 for 0.3", "model", other_body),
    Fault(
        "FE: mesh mis-graded, a/10 where edges travel",
        "mesh",
        mesh=MeshSettings(element_size=0.1, edge_element_size=0.1),
    ),
    Fault(
        "FE: gap off by h/10 at mid-side nodes, by 4 h/10 on twice the size",
        "mesh",
        lambda: must_fail.gap(ROUGH),
    ),
    Fault(
        "FE: penalty too soft, 3 E*/h",
        "penalty",
        settings=must_fail.SOFT | {"normal_stiffness": 3.0, "tangential_stiffness": 3.0},
    ),
    # With events landed on, four increments a revolution leave every metric in its band: friction
    # work follows the curve. Without, an increment loses friction work that theory on the polygon
    # of the steps has: no step is to blame, the engine is. The metric of the steps sees it too.
    Fault(
        "FE: no event landed on, 4 increments a revolution",
        "model",
        must_fail.blind,
        must_fail.LONG | {"steps_per_cycle": 4},
    ),
    Fault("theory: friction 1 % high", "model", lambda: theory(rubbing)),
    Fault("theory: signs of q, U and s flipped", "model", lambda: theory(sign=-1.0)),
    Fault("theory: nu of the upper body 0.4 for 0.3", "model", lambda: theory(other_nu)),
)


class Found(NamedTuple):
    """Values of the metrics, and budgets of all but the step's own."""

    values: dict[str, float]
    budgets: dict[str, Budget]

    def band(self, key: str) -> float:
        """|E| + u."""
        doubt = self.budgets[key].uncertainty if key in self.budgets else None
        return abs(self.values[key]) + (abs(self.values[key]) if doubt is None else doubt)

    def blamed(self, key: str) -> str:
        """The term that has the largest share of a metric, or may have; the model only where it
        stands out of its uncertainty.
        """
        if key == STEP:
            return "step"
        budget = self.budgets[key]
        parts = {
            term.name: max(abs(term.value or 0.0), term.uncertainty or 0.0) for term in budget.terms
        }
        parts["model"] = abs(budget.rest_of_error) if budget.is_resolved else 0.0
        return max(parts, key=parts.__getitem__)


def seen(faulty: Found, healthy: Found) -> dict[str, float]:
    """How many healthy bands wide each metric is that has left its own, the widest first."""
    wide = {
        key: abs(value) / healthy.band(key)
        for key, value in faulty.values.items()
        if healthy.values.get(key)
    }
    return dict(
        sorted(
            ((key, ratio) for key, ratio in wide.items() if ratio > 1),
            key=lambda key_and_ratio: -key_and_ratio[1],
        )
    )


def with_fault(fault: Fault) -> Found:
    """Metrics and budgets of a run of the paper's cycle with a fault in it."""
    settings = replace(STEPS, **fault.settings)
    with fault.plant():
        comparison = plain(load_scene("hertz-paper"), fault.mesh, settings)
        terms = budget_of(comparison, fault.mesh, settings, 1.0).budgets
    known = {}
    for term in terms:
        key = term.metric.key
        if not any(part in key for part in LEFT_OUT):
            known[key] = term
    return Found(
        {key: term_of_key.error for key, term_of_key in known.items()}
        | {STEP: comparison.metric(STEP).value or 0.0},
        known,
    )


def blame() -> Iterator[Row]:
    """A row for each fault: 0 where it was seen and the right term blamed, else 1."""
    healthy = with_fault(Fault("none", ""))
    yield Row(
        "healthy: metrics that leave their own band",
        len(seen(healthy, healthy)),
        0.0,
        f"{len(healthy.values)} metrics",
    )
    for fault in FAULTS:
        faulty = with_fault(fault)
        caught = seen(faulty, healthy)
        blamed = faulty.blamed(next(iter(caught))) if caught else "nobody"
        strongest = [f"{key} ({ratio:.3g} bands)" for key, ratio in list(caught.items())[:3]]
        how = f"seen by {', '.join(strongest)}; blamed: {blamed}"
        yield Row(fault.name, float(blamed != fault.blamed), 0.0, how)


# ------------------------------------------------------------------------------------------- sweeps
# Signed errors of every quantity; the worst instants of three metrics, of which stick edges jump
# from node to node.
FRICTIONS = [0.9, 1.0, 1.2, 1.5, 2.0]
PRESETS = ("default", "coarse")


def cheap() -> Iterator[Row]:
    """Errors between half-planes, where every one is known: how many there are, how many the cheap
    uncertainty covers.
    """
    from jobs import F, swept

    from reports.studies.sweep.solving import QUANTITIES

    names = [
        *(f"error.{name}" for name in QUANTITIES),
        "pressure",
        "shear",
        "stick_edge",
    ]
    known = {}
    for preset in PRESETS:
        study = {"scene": "hertz-paper", "figures": names, "uncertainty": "cheap", "preset": preset}
        finished = swept(study, F | {"values": FRICTIONS})[0]
        for name in names:
            for f, e, u in zip(
                *(finished[key].tolist() for key in ("f", name, f"{name}.uncertainty")), strict=True
            ):
                known |= (
                    {f"{name} at f = {f:g}, {preset}": abs(e) / u} if math.isfinite(e + u) else {}
                )
    missed = [f"{where} ({share:.2g})" for where, share in known.items() if share > 1]
    shares = sorted(known.values())
    how = (
        f"hertz-paper, {len(names)} figures, {len(FRICTIONS)} frictions, {' and '.join(PRESETS)}"
        " mesh"
    )
    yield Row("known errors between half-planes", len(known), None, how)
    yield Row(
        "... covered by the cheap uncertainty",
        len(known) - len(missed),
        None,
        "; ".join(missed) or "all",
    )
    yield Row("... error over uncertainty, median", shares[len(shares) // 2], None, "")
    for tenths in (1, 9):
        yield Row(
            f"... error over uncertainty, {tenths} of ten below",
            shares[len(shares) * tenths // 10],
            None,
            "",
        )


# ------------------------------------------------------------------------------------ random models
# W below this share of A f^2 P^2, P the largest load, hardly slips, and is counted apart.
LITTLE = LITTLE_SLIP
MEAN = 90.0


def random_profile(draw: np.random.Generator, number: int) -> dict[str, Any]:
    """A profile [mm] such that contacts are about a millimetre wide."""
    kinds: list[dict[str, Any]] = [
        {"kind": "hertz", "radius": 1000.0},
        {"kind": "flat_rounded", "radius": 1000.0, "flat_half_length": draw.uniform(0.2, 2.8)},
        {"kind": "power_law", "exponent": draw.uniform(1.6, 5), "length": 1.0, "rise": 5e-4},
        {
            "kind": "compound",
            "inner_radius": 1e3,
            "outer_radius": draw.uniform(300, 3000),
            "inner_half_length": draw.uniform(0.3, 1),
        },
        {"kind": "polynomial", "length": 1.0, "rises": [5e-4, draw.uniform(1e-4, 1e-3)]},
    ]
    return kinds[number % len(kinds)]


def random_model(draw: np.random.Generator, number: int) -> Scene:
    """An ellipse that stays away from gross sliding by 1e-3 to 0.9 of f P; f from 0.05 to 1.5;
    every second on blocks.
    """
    f = np.exp(draw.uniform(np.log(0.05), np.log(1.5)))
    swing = draw.uniform(0, 0.95)
    phase = draw.uniform(0, 180)
    offset = draw.random()
    away = np.exp(draw.uniform(np.log(1e-3), np.log(0.9)))
    angle = np.linspace(0, 2 * np.pi, 4001)
    wave = offset + (1 - offset) * np.cos(angle - np.radians(phase))
    most = (1 - away) / np.max(np.abs(wave) / (f * MEAN * (1 + swing * np.cos(angle))))
    block = {"kind": "block", "width": draw.uniform(8, 30), "height": draw.uniform(4, 30)}
    loads = {
        "mean_normal_load": MEAN,
        "normal_amplitude": MEAN * swing,
        "mean_tangential_load": most * offset,
    }
    arguments = {
        "name": f"random-{number}",
        "material": load_scene("hertz-paper").model_dump(mode="json")["material"],
        "profile": random_profile(draw, number // 2),
        "friction": {"coefficient": float(f)},
        "load": {
            "kind": "ellipse",
            **loads,
            "tangential_amplitude": most * (1 - offset),
            "phase_degrees": phase,
        },
    }
    return Scene.model_validate(
        arguments | ({"bodies": {"lower": block, "upper": block}} if number % 2 else {})
    )


def models(count: int = 60, seed: int = 2) -> int:
    """Whether the stated uncertainty of W covers its error; none is taken out, refused scenes are
    counted apart.

    Half-planes against theory; blocks against a/320, half the growth of elements inwards and a
    tenth of the step tolerance, whose error is a sixth of the default's or less.
    """
    draw = np.random.default_rng(seed)
    ratios = []
    outcome = Counter[str]()
    for number in range(count):
        scene = random_model(draw, number)
        head = (
            f"{number:3d} {scene.profile.kind:13s}"
            f" {'half-planes' if scene.bodies.half_planes else 'blocks':11s}"
        )
        try:
            answer = halfplane_fe.solve(scene)
            finer = {
                "mesh": MeshSettings(edge_element_size=1 / 320, growth=0.1),
                "settings": SolverSettings(step_tolerance=5e-5),
            }
            if scene.bodies.half_planes:
                true = THEORY(scene, x=[0.0], fields=("dissipation",)).dissipation
            else:
                true = halfplane_fe.solve(scene, **finer, scales=answer.scales).dissipation
        except (InputError, ConvergenceError) as reason:
            outcome["refused or not converged"] += 1
            print(f"{head} {reason}", flush=True)
            continue
        work = true / (
            2 / answer.scales.modulus * (scene.friction.coefficient * answer.scales.load) ** 2
        )
        error, stated = (
            (value / max(true, 1e-300))
            for value in (answer.dissipation - true, answer.dissipation_uncertainty)
        )
        outcome[
            "hardly slips: " * (work < LITTLE)
            + ("covered" if abs(error) <= stated else "not covered")
        ] += 1
        ratios += [stated / max(abs(error), 1e-300)] if work >= LITTLE else []
        print(
            f"{head} W {work:.1e} of A f^2 P^2, error {error:+.1e}, stated {stated:.1e}", flush=True
        )
    print(
        f"seed {seed}: {dict(outcome)}, stated over true error, median"
        f" {np.median(ratios) if ratios else np.nan:.3g}"
    )
    return 0


def values(
    count: int = 30, seed: int | None = None, preset: str = "default", store: str = ""
) -> int:
    """Whether the stated uncertainty of every value covers its error, between random half-planes
    against theory; without a seed another one is drawn each time, and printed.
    """
    return _shown("values", judge, count, seed, preset, store)


def bodies(
    count: int = 40, seed: int | None = None, preset: str = "default", store: str = ""
) -> int:
    """The same of real bodies, unlike materials, bulk stress and tilt, against finer meshes."""
    return _shown("bodies", judge_bodies, count, seed, preset, store)


def theory_errors(count: int = 20, seed: int | None = None, store: str = "") -> int:
    """Whether the errors that half-plane theory states of its own values cover the true ones."""
    table = judge_theory(count, _seed(seed), functools.partial(print, flush=True))
    for line in table.lines():
        print(line)
    if store:
        _keep(f"theory {table.seed}", table.content())
    return 0


def _seed(seed: int | None) -> int:
    """The seed that is asked for, or another one each time."""
    return int(np.random.SeedSequence().generate_state(1)[0]) if seed is None else seed


def _keep(name: str, table: dict[str, Any]) -> None:
    """Put a table into the store, with the commit that made it."""
    content = json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}
    content[name] = table | {"commit": code_commit("*.py")}
    STORE.write_text(json.dumps(content, indent=1) + "\n", "utf-8")


def _shown(
    kind: str,
    tables_of: Callable[[int, int, str, Callable[[str], None]], Tables],
    count: int,
    seed: int | None,
    preset: str,
    store: str,
) -> int:
    """Prints a line for each scene as it is done, then the tables; keeps them where asked to."""
    tables = tables_of(count, _seed(seed), preset, functools.partial(print, flush=True))
    for line in tables.lines():
        print(line)
    if store:
        _keep(f"{kind} {tables.seed} {preset}", tables.content())
    return 0


# -------------------------------------------------------------------------------- measured profiles
# Profile and fit; what the engine promises of any W, which is all that is uncertain where W does
# not depend on the fitted numbers.
FITS = (("hertz", "hertz"), ("hertz", "even_polynomial"), ("hertz", "smoothing_spline"))
FITS += (("flat_rounded", "flat_rounded"), ("flat_rounded", "smoothing_spline"))
SPAN = 3.0  # mm
PROMISED = 1e-9


def measured_profile(random: np.random.Generator, number: int) -> tuple[Scene, Scene]:
    """A true scene, and with noisy rows and a fit that can describe them; InputError where the fit
    has no answer.

    A parabola of radius 500 to 2,000 mm or a flat of half-length 0.2 to 0.7 mm, 31 to 1,001 uneven
    rows over 3 mm with the middle up to 0.3 mm off, noise of 1 to 50 nm, an ellipse of loads whose
    largest contact is a = 1 mm.
    """
    shape, kind = FITS[number % len(FITS)]
    radius = float(random.uniform(500, 2000))
    truth: Hertz | FlatRounded = Hertz(radius=radius)
    if shape == "flat_rounded":
        truth = FlatRounded(radius=radius / 3, flat_half_length=float(random.uniform(0.2, 0.7)))
    rows = int(np.exp(random.uniform(np.log(31), np.log(1001.5))))
    noise = float(np.exp(random.uniform(np.log(1e-6), np.log(50e-6))))
    # never two rows in one place
    x = np.linspace(-SPAN / 2, SPAN / 2, rows) + SPAN / rows * random.uniform(-0.4, 0.4, rows)
    middle = float(random.uniform(-0.3, 0.3))
    h = (
        truth.height(x - middle)
        + noise * random.standard_normal(rows)
        + random.uniform(-1e-3, 1e-3)
    )
    base = load_scene("hertz-paper")
    share = float(random.uniform(0.0, 0.6))
    mean = float(contact_of(truth, base.material).load(1.0)) / (1 + share)
    load = {"mean_normal_load": mean, "normal_amplitude": share * mean, "mean_tangential_load": 0.0}
    load["tangential_amplitude"] = (
        float(random.uniform(0.2, 0.9)) * base.friction.coefficient * mean * (1 - share)
    )
    load["phase_degrees"] = float(random.uniform(30, 150))
    # the paper's parabola may slide; W of the steady cycle does not depend on it
    load["initial_loading"] = "straight"
    fitted = {
        "kind": "tabulated",
        "points": np.column_stack([x, h]),
        "fit": {"kind": kind, "noise": noise},
    }
    return base.vary(load=load, profile=truth), base.vary(
        name=f"case {number}", load=load, profile=fitted
    )


def profiles(count: int = 200, seed: int = 1) -> int:
    """Whether W of noisy profilometer rows is answered, and lies within the uncertainty that
    `reports.profile_fit` states.
    """
    from reports.profile_fit import fit_uncertainty

    random = np.random.default_rng(seed)
    outcomes = defaultdict[str, list[tuple[float, float]]](list)
    for number in range(count):
        label = " fitted by ".join(FITS[number % len(FITS)])
        try:
            true, scene = measured_profile(random, number)
            dissipation = fit_uncertainty(scene).dissipation
        except InputError as fault:
            print(f"case {number}, {label}: {fault}")
            continue
        assert dissipation is not None
        truth = THEORY(true, x=[0.0], fields=("dissipation",)).dissipation
        outcomes[label].append(
            (abs(dissipation.value / truth - 1), dissipation.uncertainty / truth + PROMISED)
        )
    answered = sum(map(len, outcomes.values()))
    print(f"seed {seed}: {answered} of {count} answered")
    for label, rows in outcomes.items():
        error, stated = 100 * np.array(rows).T
        inside = 100 * np.mean(error <= stated)
        rms = np.sqrt(np.mean(error**2))
        words = (
            f"error rms {rms:.2g} %, largest {error.max():.2g} %; stated, median"
            f" {np.median(stated):.2g} %"
        )
        print(f"{label}: W within its uncertainty in {inside:.1f} % of {len(rows)}; {words}")
    share = float(
        np.mean([error <= stated for rows in outcomes.values() for error, stated in rows])
    )
    print(f"all: W within its uncertainty in {100 * share:.1f} %")
    return 1 if answered < count or share < 0.95 else 0


COMMANDS: dict[str, Callable[..., int]] = {
    "values": values,
    "bodies": bodies,
    "theory": theory_errors,
    "models": models,
    "profiles": profiles,
}

if __name__ == "__main__":
    kind, *words = sys.argv[1:]
    arguments = [int(word) if word.isdecimal() else word for word in words]
    sys.exit(COMMANDS[kind](*arguments))
