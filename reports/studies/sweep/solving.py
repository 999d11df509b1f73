"""What a sweep can keep of a point, and what a worker does: points in as JSON, figures out as JSON.

A figure is a metric's key ("stick_edge"), or "fe.", "exact." or "error." before a quantity
("fe.peak_pressure"); "error." is that of the finite elements over that of half-plane theory, minus
1. Quantities are those of the last cycle. Where both engines run, theory is evaluated on the points
and instants of the finite elements, so that sampling is the same in both; under a prescribed
displacement each engine finds loads of its own, and its values are those of its own instants.

A point that fails is an answer too, with its reason and record.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field, replace
from functools import cache, lru_cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from reports.comparison.datum import effects_between, lacks_datum
from reports.comparison.metrics import METRICS
from reports.units import energy_unit, units
from scenes import (
    BodyEffects,
    ContactSolution,
    ConvergenceError,
    EllipseLoad,
    Friction,
    InputError,
    PolygonLoad,
    Rig,
    Scene,
)
from scenes.files import source_digest
from scenes.scene import WORDS, Load

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution, SolverSettings
    from halfplane_fe.scales import Scales
    from meshes import MeshSettings
    from reports.comparison import Comparison
    from reports.comparison.metrics import Metric

Values = dict[str, float | None]
# What numbers depend on: the engines and what they stand on, and what a worker imports of
# `reports`. In a checkout the packages lie at the top, in the wheel inside `halfplane`.
_REPORTS = __name__.removesuffix(".studies.sweep.solving")
_BESIDE_REPORTS = _REPORTS.removesuffix("reports")
_PACKAGES_OF_CODE = (
    *(_BESIDE_REPORTS + name for name in ("scenes", "semi_analytic", "meshes", "halfplane_fe")),
    *(f"{_REPORTS}.{name}" for name in ("comparison", "units")),
)
_LIBRARIES = ("numpy", "scipy", "scikit-fem", "gmsh", "pydantic")
# Roache's index of two grids, 3/(2^p - 1) with p = 3/2: where tractions end as a root, errors fall
# no faster.
_MESH_FACTOR = 1.64
# A change by twice the distance leaves as much again, if the error falls by the first power of the
# distance; it falls faster.
_FAR_FIELD_FACTOR = 2.0


# ------------------------------------------------------------------------------------------ figures
@dataclass(frozen=True)
class Quantity:
    """A quantity of one solution, which a sweep can keep as a figure: how its value is taken, its
    words, and the fields of the half-plane engine that it needs.

    `edges` names the field of a finite-element solution that states how far its edges may be from
    the true ones. With `at_mean_load`, `value` has one for each instant, (n,).
    """

    value: Callable[[ContactSolution], Any]
    words: str
    fields: tuple[str, ...] = ()
    edges: str = ""
    at_mean_load: bool = False

    def value_in(self, solution: ContactSolution, scene: Scene) -> float:
        """The value of the quantity in a solution of a scene; at one load of the last cycle, the
        mean or the largest, where `at_mean_load`.
        """
        value = self.value(solution)
        return (
            _value_at_mean_load(solution, value, scene.load) if self.at_mean_load else float(value)
        )


def _value_at_mean_load(solution: ContactSolution, series: np.ndarray, stated_load: Load) -> float:
    """Value of a quantity at one normal load of the last cycle: at the mean load P0 where the loads
    that the scene states (`stated_load`) are an ellipse, else at the largest load. Linear between
    the loads of the instants.

    `series` (n,) has the quantity at all instants of the solution. Where an ellipse prescribes the
    approach in place of P, the largest load is taken too.
    """
    cycle_indices = solution.last_cycle  # instants of the last cycle
    normal_loads = solution.normal_load[cycle_indices]
    load_of_value = float(np.max(normal_loads))
    if isinstance(stated_load, EllipseLoad) and not stated_load.states_approach:
        load_of_value = stated_load.mean_normal_load
    ascending_indices = np.argsort(normal_loads, kind="stable")
    return float(
        np.interp(
            load_of_value, normal_loads[ascending_indices], series[cycle_indices][ascending_indices]
        )
    )


_CONTACT_EDGE_UNCERTAINTY = "contact_edge_uncertainty"
_STICK_EDGE_UNCERTAINTY = "stick_edge_uncertainty"
QUANTITIES: dict[str, Quantity] = {
    "dissipation": Quantity(
        lambda s: s.dissipation,
        "dissipation of the last cycle [energy / thickness]",
        ("dissipation",),
    ),
    "peak_dissipation": Quantity(
        lambda s: np.max(s.dissipation_density),
        "largest pointwise dissipation [energy / area]",
        ("dissipation_density",),
    ),
    "peak_pressure": Quantity(
        lambda s: np.max(s.pressure[s.last_cycle]), "largest pressure [stress]", ("pressure",)
    ),
    "p0": Quantity(
        lambda s: s.pressure.max(axis=1),
        "peak pressure at the mean load, linear between instants [stress]",
        ("pressure",),
        at_mean_load=True,
    ),
    "peak_shear": Quantity(
        lambda s: np.max(np.abs(s.shear[s.last_cycle])), "largest |q| [stress]", ("shear",)
    ),
    "contact_half_width": Quantity(
        lambda s: s.contact_half_width,
        "contact half-width at the mean load, linear between instants [length]",
        edges=_CONTACT_EDGE_UNCERTAINTY,
        at_mean_load=True,
    ),
    "largest_half_width": Quantity(
        lambda s: np.max(s.contact_half_width[s.last_cycle]),
        "largest contact half-width [length]",
        edges=_CONTACT_EDGE_UNCERTAINTY,
    ),
    "stick_half_width": Quantity(
        lambda s: s.stick_half_width[s.last_cycle][
            np.argmax(np.abs(s.tangential_load[s.last_cycle]))
        ],
        "stick half-width where |Q| is largest [length]",
        edges=_STICK_EDGE_UNCERTAINTY,
    ),
    "permanent_stick_half_width": Quantity(
        lambda s: s.permanent_stick_half_width,
        "half-width that sticks through the cycle [length]",
        edges=_STICK_EDGE_UNCERTAINTY,
    ),
    "permanent_stick_centre": Quantity(
        lambda s: (
            float("nan")
            if s.permanent_stick_edges is None
            else float(np.mean(s.permanent_stick_edges))
        ),
        "middle of what sticks through the cycle, with bulk stress or tilt [length]",
    ),
    "stroke": Quantity(
        lambda s: np.ptp(s.tangential_displacement[s.last_cycle]),
        "range of the tangential displacement [length]",
        ("tangential_displacement",),
    ),
    "loop_work": Quantity(
        lambda s: s.loop_work,
        "closed integral of Q dU, with its bulk term [energy / thickness]",
        ("loop_work",),
    ),
}
# Metrics that take what the bodies add to the displacements of half-planes.
_DISPLACEMENT_METRICS = {"tangential_displacement", "displacement_amplitude", "approach_amplitude"}
_ENGINES = {"fe": "the finite elements", "exact": "half-plane theory"}


def is_error(name: str) -> bool:
    """Whether a value of a sweep, by its name such as "error.p0", states how far both engines are
    apart, and is 0 where they agree.
    """
    return name in METRICS or name.startswith("error.")


def display_factor(name: str) -> float:
    """Factor by which a value of the table is multiplied where it is shown: 100 for errors and
    metrics, which are in per cent, else 1. `name` is that of the value, such as "error.p0".
    """
    return 100.0 if is_error(name) else 1.0


def label_of(name: str, scene: Scene) -> tuple[str, str]:
    """The words for a quantity of a sweep such as "fe.p0", and its unit as it is shown: a unit of
    the scene, or per cent and of what.

    The prefix of `name` says whose value it is: "fe." of the finite elements, "exact." of
    half-plane theory; "error." is finite elements/theory − 1. A name without prefix is the key of a
    metric, which compares both (`METRICS`). `QUANTITIES` has the words of each quantity, its
    dimension, such as "stress", in brackets behind them.

    >>> from scenes import load_scene
    >>> [
    ...     label_of(name, load_scene("hertz-paper"))[1]
    ...     for name in ("fe.p0", "exact.dissipation", "error.p0", "stick_edge")
    ... ]
    ['MPa', 'N·mm/mm', '%', '% of a_ref']
    """
    if name in METRICS:
        # `unit` of a metric: of what the per cent are, such as "of a_ref"
        return METRICS[name].label, f"% {METRICS[name].unit}"
    prefix, _, quantity = name.partition(".")
    quantity_in_words, _, dimension = QUANTITIES[quantity].words.removesuffix("]").rpartition(" [")
    if prefix == "error":
        return f"{quantity_in_words}, finite elements/theory − 1", "%"
    _, unit_of_length, unit_of_stress = units(scene)
    unit_of_energy = energy_unit(scene)
    unit_by_dimension = {
        "stress": unit_of_stress,
        "length": unit_of_length,
        "energy / thickness": unit_of_energy,
        "energy / area": f"{unit_of_energy}²",
    }
    # _ENGINES: words of "fe" and "exact"
    return f"{quantity_in_words}, {_ENGINES[prefix]}", unit_by_dimension[dimension]


def check_figures(figures: Sequence[str], engines: Sequence[str], uncertainty: str) -> None:
    """Check the names of the quantities (`figures`) that a sweep is to compute.

    A name is the key of a metric (`METRICS`), which compares both engines, or one of `QUANTITIES`
    with a prefix. The prefix is "fe." of the finite elements, "exact." of half-plane theory, or
    "error." for finite elements/theory − 1. `engines` are those that run, "fe" and "exact".
    `uncertainty` is how that of the quantities is found: "none", "cheap" (a few more runs) or
    "budget" (a whole error budget).

    Raises
    ------
    ValueError
        Where a name is no quantity, is given twice, or needs one of the `engines` that does not
        run; where the kind of uncertainty does not fit the quantities or the engines.
    """
    # each name
    for name in figures:
        prefix, _, quantity = name.partition(".")
        # _ENGINES: words of "fe" and "exact"
        is_quantity = prefix in (*_ENGINES, "error") and quantity in QUANTITIES
        if name not in METRICS and not is_quantity:
            raise ValueError(
                f"figures: {name!r} is none: it is the key of a metric (docs/metrics.md), or fe.,"
                f" exact. or error. before one of {', '.join(QUANTITIES)}"
            )
        # an error or a metric needs both engines
        needed_engines = set(_ENGINES) if is_error(name) else {prefix}
        missing_engines = needed_engines - set(engines)
        if missing_engines:
            raise ValueError(f"figures: {name!r} needs engines = [..., {min(missing_engines)!r}]")
        if uncertainty == "budget" and name not in METRICS:
            raise ValueError(
                f"figures: {name!r} is no metric, and an error budget is of metrics; take"
                " uncertainty = 'cheap'"
            )

    # all of them, and the kind of uncertainty
    if len(set(figures)) < len(figures):
        raise ValueError("figures: one is given twice")
    if uncertainty != "none" and "fe" not in engines:
        raise ValueError(
            "uncertainty: half-plane theory is exact to rounding; with it alone take uncertainty ="
            " 'none'"
        )
    if uncertainty == "budget" and "exact" not in engines:
        raise ValueError("uncertainty: an error budget needs both engines")


def check_figures_of_driven_scene(scene: Scene, figures: Sequence[str]) -> None:
    """InputError where the scene prescribes a displacement and one of a sweep's `figures`, the
    names of the values that it keeps, is a metric. Metrics compare both engines, finite elements
    and half-plane theory, under one load. Under a prescribed displacement each engine finds loads
    of its own.

    An error can be had instead, such as "error.stroke": finite elements/theory − 1 of one of the
    `QUANTITIES`.
    """
    if not scene.load.is_driven:
        return
    metric_names = [name for name in figures if name in METRICS]
    if metric_names:
        raise InputError(
            f"figures: {metric_names[0]!r} compares both engines under one load, and under a"
            " prescribed displacement each finds loads of its own: take error. before one of"
            f" {', '.join(QUANTITIES)}"
        )


def _value_of_quantity(
    name: str,
    scene: Scene,
    fe_solution: ContactSolution | None,
    theory: ContactSolution | None,
) -> tuple[float | None, str]:
    """The value of a quantity such as "fe.peak_pressure" or "error.stroke" for a scene of a sweep:
    (value, ""), or (None, reason) where it has no value.

    The prefix says whose quantity it is: "fe" of the finite elements, "exact" of half-plane theory,
    "error" finite elements/theory − 1. A solution is None where that engine did not run.

    A stroke, the range of the tangential displacement, has no value where half-planes stand for
    finite bodies: half-planes have no datum, a place at rest from which displacements are counted.
    """
    prefix, _, quantity = name.partition(".")
    # the values of the engines that the prefix needs
    value_by_engine = {}
    for engine, solution in (("fe", fe_solution), ("exact", theory)):
        if solution is not None and prefix in (engine, "error"):
            # displacements of half-planes that stand for finite bodies
            if quantity == "stroke" and lacks_datum(solution):
                return None, "half-planes have no datum: their stroke is not that of these bodies"
            # QUANTITIES: how the value of each is taken from a solution
            value_by_engine[engine] = QUANTITIES[quantity].value_in(solution, scene)
            if not math.isfinite(value_by_engine[engine]):
                return None, f"there is none in {_ENGINES[engine]}"

    if prefix != "error":
        return value_by_engine[prefix], ""
    if not value_by_engine["exact"]:
        return None, "it is 0 in half-plane theory, so nothing is relative to it"
    return value_by_engine["fe"] / value_by_engine["exact"] - 1, ""


def _uncertainty_of_edges(
    name: str,
    scene: Scene,
    fe_solution: ContactSolution,
    theory: ContactSolution | None,
) -> float:
    """Uncertainty that a finite-element solution itself states for a half-width of contact or stick
    zone, the quantity `name` such as "fe.contact_half_width"; 0 for other quantities, and where it
    states none.

    It is the larger uncertainty of both edges, or that of the only edge which has an estimate, as
    the median over the instants of the last cycle which have one [length]. Of an error (prefix
    "error.", finite elements/theory − 1) it is divided by theory's half-width.
    `theory` is None where that engine did not run.
    """
    prefix, _, quantity = name.partition(".")
    # field of the solution with the uncertainty of these edges; "" where the quantity has none
    # QUANTITIES: how the value of each is taken from a solution
    field_name = "" if prefix == "exact" else QUANTITIES[quantity].edges
    if not field_name:
        return 0.0
    # (instants, 2): left and right edge
    edge_uncertainties = np.asarray(getattr(fe_solution, field_name))[fe_solution.last_cycle]
    # NaN where neither edge has an estimate
    uncertainty_of_worse_edge = np.fmax.reduce(edge_uncertainties, axis=1)
    uncertainty_of_worse_edge = uncertainty_of_worse_edge[np.isfinite(uncertainty_of_worse_edge)]

    # over the half-width by theory, where it is an error
    reference_length = 1.0
    if prefix == "error" and theory is not None:
        reference_length = QUANTITIES[quantity].value_in(theory, scene)
    if not len(uncertainty_of_worse_edge) or not reference_length:
        return 0.0
    uncertainty = float(np.median(uncertainty_of_worse_edge)) / reference_length
    return uncertainty if math.isfinite(uncertainty) else 0.0


# ----------------------------------------------------------------------------------------- a worker
@cache
def code_versions() -> dict[str, str]:
    """Versions of what a result depends on: hash of the project's code, version of Python and of
    the libraries. They are read once in a process, and are part of the address of a result.
    """
    code = source_digest(*_PACKAGES_OF_CODE, __name__)[:16]
    python = ".".join(platform.python_version_tuple()[:2])
    return {"code": code, "python": python} | {name: version(name) for name in _LIBRARIES}


@dataclass(frozen=True, eq=False)
class Question:
    """What is to be computed at a point of a sweep: the scene, the settings of mesh and solver, and
    what is kept.
    """

    scene: Scene
    mesh: MeshSettings
    solver: SolverSettings
    engines: Sequence[str]  # that run: "fe", "exact" or both
    figures: Sequence[str]  # names of the values that are kept, such as "error.peak_pressure"
    uncertainty: str  # how that of the values is found: "none", "cheap" or "budget"
    share_condensations: bool  # whether points that differ in loads and friction share a mesh

    def as_json(self) -> dict[str, Any]:
        """The question as JSON values, as it travels to a worker and as it is stored."""
        json_values = {
            name: getattr(self, name)
            for name in ("engines", "figures", "uncertainty", "share_condensations")
        }
        return {
            "scene": self.scene.model_dump(mode="json"),
            "mesh": asdict(self.mesh),
            "solver": asdict(self.solver),
        } | json_values

    @property
    def address(self) -> str:
        """Name under which the result of this question is stored: SHA-256 of all that its numbers
        depend on, the versions of the code included. Questions whose scenes differ in texts alone,
        such as a title, have one address; so have those that differ in mesh or solver where no
        finite elements run.

        A question has a scene, settings of mesh and solver, `engines` that run ("fe", "exact"),
        `figures` (names of the values that are kept), and the way to find their uncertainty.
        """
        content = self.as_json() | {
            "engines": sorted(self.engines),
            "figures": sorted(self.figures),
            "versions": code_versions(),
        }
        # WORDS: keys of a scene that are texts
        scene = content["scene"]
        content["scene"] = {key: scene[key] for key in scene if key not in WORDS}
        # without finite elements their settings do not count
        if "fe" not in self.engines:
            content = {name: content[name] for name in ("scene", "engines", "figures", "versions")}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def solve_task(text: str) -> str:
    """Solve the points of a task of a sweep in a worker process: a JSON text in, a JSON text out.
    Nothing is solved where the worker has other code or libraries than the sender of the task.

    Parameters
    ----------
    text
        JSON of {"versions": name -> version of the sender's code and libraries, "points": the
        question of each, which is its scene, settings of mesh and solver, and what is asked for}

    Returns
    -------
    str
        JSON of {"mismatch": sentence on versions that differ or "", "answers": one for each point,
        none after a mismatch}
    """
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

    task = json.loads(text)

    # refuse other versions
    versions_of_sender = task["versions"]
    versions_of_worker = code_versions()
    differences = []
    for name in sorted(versions_of_sender.keys() | versions_of_worker.keys()):
        sender_version = versions_of_sender.get(name, "missing")
        worker_version = versions_of_worker.get(name, "missing")
        if sender_version != worker_version:
            differences.append(f"{name} is {sender_version} here and {worker_version} there")
    if differences:
        worker = f"worker {platform.node()} (process {os.getpid()})"
        return json.dumps({"mismatch": f"{worker}: {', '.join(differences)}", "answers": []})

    # solve the points one after the other, with one thread in numerical libraries
    questions = []
    for content in task["points"]:
        scene = Scene.model_validate_json(json.dumps(content.pop("scene")))
        mesh = MeshSettings(**content.pop("mesh"))
        solver = SolverSettings(**content.pop("solver"))
        questions.append(Question(scene, mesh, solver, **content))
    with threadpool_limits(limits=1):
        answers = [_answer_to_question(question) for question in questions]
    return json.dumps({"mismatch": "", "answers": answers}, allow_nan=False)


def _answer_to_question(question: Question) -> dict[str, Any]:
    """Solve one point of a sweep; an exception of the solvers becomes an answer that states it.

    The answer has JSON values. They are its status "done" or "failed", the reason of a failure, the
    values that are kept ("figures"), notes on them, the record of the solution, the seconds it
    took, and the name of the machine. `question` is the point's scene with settings and the names
    of the values that are kept.
    """
    start_seconds = time.perf_counter()
    try:
        solved_keys = _solve(question)
    except ConvergenceError as failure:
        solved_keys = {
            "status": "failed",
            "reason": f"not converged: {failure}",
            "record": _record_of_solution(failure.partial),  # up to the failure
        }
    except InputError as failure:
        solved_keys = {"status": "failed", "reason": str(failure)}
    except (ArithmeticError, ValueError, RuntimeError, MemoryError, LookupError) as failure:
        # One point must not end a sweep of thousands; what went wrong stands in its row, and
        # nothing is taken for an answer.
        solved_keys = {"status": "failed", "reason": f"{type(failure).__name__}: {failure}"}

    default_keys: dict[str, Any] = {
        "status": "done",
        "reason": "",
        "figures": {},
        "notes": {},
        "record": {},
    }
    seconds = time.perf_counter() - start_seconds
    return default_keys | solved_keys | {"seconds": seconds, "host": platform.node()}


def _solve(question: Question) -> dict[str, Any]:
    """Solve one point of a sweep by the engines that it asks for. Returns JSON values: "figures",
    the values that it asks for and their uncertainties by name; "notes" on them by the same names;
    "record", how the solution came about.

    A number that is not finite becomes None, and a note states it.

    `question` is the point's scene with settings. Its `engines` are "fe" (finite elements) and
    "exact" (half-plane theory). Its `uncertainty` is "none", "cheap" (from a few more runs) or
    "budget" (from a whole error budget).
    """
    # the values: theory is solved in `evaluate`
    fe_solution = None
    notes: dict[str, str] = {}
    if "fe" in question.engines:
        fe_solution, notes = _solve_finite_elements(question)
    evaluation = evaluate(question, fe_solution)
    theory = evaluation.theory
    values = dict(evaluation.values)
    record = _record_of_solution(theory if fe_solution is None else fe_solution)
    notes |= evaluation.notes

    # their uncertainties; the functions add reasons to `notes` where there is none
    if fe_solution is not None:
        if theory is not None:
            record["notes"] += [f"half-plane theory: {note}" for note in theory.record.notes]
        if question.uncertainty == "cheap":
            values |= _uncertainty_by_coarser_runs(question, fe_solution, evaluation, notes)
        if question.uncertainty == "budget":
            values |= _uncertainty_by_budget(question, evaluation, notes)

    # JSON has neither infinity nor NaN
    for name, value in values.items():
        if value is not None and not math.isfinite(value):
            notes.setdefault(name, f"the value is {value}")
    finite_values = {
        name: None if value is None or not math.isfinite(value) else float(value)
        for name, value in values.items()
    }
    return {"figures": finite_values, "notes": notes, "record": record}


def _record_of_solution(solution: ContactSolution | None) -> dict[str, Any]:
    """How a solution came about, as JSON values. They are convergence, notes, numbers of instants
    ("steps") and surface points, its last time, the first cycle that is steady, counts and seconds
    of the computation. "worst" is the worst residual of each law of contact and equilibrium. Empty
    without a solution.
    """
    if solution is None:
        return {}
    # certificates: law -> its residuals
    worst_residuals = {
        law: float(max(residuals, default=0.0))
        for law, residuals in solution.record.certificates.items()
    }
    return {
        "converged": solution.record.converged,
        "message": solution.record.message,
        "notes": list(solution.record.notes),
        "steps": len(solution.time),
        "points": len(solution.x),
        "time": float(solution.time[-1]),
        "steady_from": solution.steady_from,
        "counts": {name: int(count) for name, count in solution.work.counts.items()},
        "seconds": {name: float(seconds) for name, seconds in solution.work.seconds.items()},
        # JSON has no infinity
        "worst": {
            law: residual if math.isfinite(residual) else None
            for law, residual in worst_residuals.items()
        },
    }


def _solve_finite_elements(question: Question) -> tuple[FiniteElementSolution, dict[str, str]]:
    """Solve one point of a sweep by finite elements. Returns the solution, and a note (under the
    key "") where it was solved on a mesh of its own although a shared one was asked for.

    With `question.share_condensations` a group of points that differ in loads and friction shares a
    mesh, whose factorisation is then done once. The mesh is made for the largest load. Where the
    contact leaves its fine part, or may move with a tilt, the point gets a mesh of its own. So does
    a point whose load prescribes the approach in place of P (`states_approach`).

    `question` has the point's scene, and the settings of mesh and solver.
    """
    import halfplane_fe

    load = question.scene.load
    notes: dict[str, str] = {}
    if question.share_condensations and (load.tilt is not None or load.moment_is_given):
        notes = {"": "the contact moves with the tilt; solved on bodies of its own"}
    elif question.share_condensations and load.states_approach:
        notes = {"": "the load follows from the approach; solved on bodies of its own"}
    elif question.share_condensations:
        try:
            # size of contact for which the shared mesh is made
            scales = _shared_scales(question.scene)
            fe_solution = halfplane_fe.solve(
                question.scene, question.mesh, question.solver, scales=scales
            )
            return fe_solution, {}
        except ConvergenceError as failure:
            if "reached the end of the meshed side" not in str(failure):
                raise
        notes = {"": "the contact left the side that its group shares; solved on bodies of its own"}
    return halfplane_fe.solve(question.scene, question.mesh, question.solver), notes


def _shared_scales(scene: Scene) -> Scales:
    """The length and load scales of contact for which the shared mesh of a group of scenes is made:
    those of the same bodies under the largest load alone, without friction. They are the same for
    scenes that differ in friction, in the history of the loads, or in their texts, such as names
    and titles.
    """
    from halfplane_fe.scales import largest_load

    # Texts (the keys WORDS) change no number, but would keep points of one group apart.
    default_texts = {
        name: Scene.model_fields[name].get_default(call_default_factory=True) for name in WORDS
    }
    # P up to its largest value, Q = 0
    load_path = PolygonLoad(initial_loading=((largest_load(scene), 0.0),))
    normalised_scene = scene.vary(
        **default_texts,
        friction=Friction(coefficient=0.0),
        load=load_path,
        rig=Rig(),  # which changes no contact under a given load
        cycles=1,
    )
    return _scales_of(normalised_scene.model_dump_json())  # from a coarse solve, which is cached


@lru_cache(maxsize=256)
def _scales_of(scene_json: str) -> Scales:
    """Length and load scales of contact for which a mesh is made, from a coarse solve of a scene
    that is given as JSON text and has neither friction nor tangential load.

    Scales that do not hold for the scenes with friction are left out: the innermost place of an
    edge, the dissipation, and the values of the coarse solve.
    """
    from halfplane_fe.scales import find_scales

    scales = find_scales(Scene.model_validate_json(scene_json), Counter())
    return replace(scales, inner=0.0, dissipation=float("nan"), values=None)


@dataclass
class Evaluation:
    """The values of a point of a sweep, each by the name of its quantity, with what they were taken
    from.

    Attributes
    ----------
    theory
        solution of half-plane theory; None where not asked for
    comparison
        of both engines; None where no metric is asked for
    values
        None where a quantity has no value
    notes
        why a quantity has no value
    stated_uncertainty
        what the finite-element solution states itself; 0 where it states none
    """

    theory: ContactSolution | None = None
    comparison: Comparison | None = None
    values: Values = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    stated_uncertainty: dict[str, float] = field(default_factory=dict)


def _effects_of_rig(scene: Scene) -> BodyEffects | None:
    """What the bodies add to half-planes, where a displacement is prescribed between their bases;
    else None.
    """
    if not scene.load.is_driven or scene.bodies.half_planes:
        return None
    import halfplane_fe

    return halfplane_fe.body_effects(scene)


def evaluate(
    question: Question, fe_solution: ContactSolution | None, *, polygon: bool = False
) -> Evaluation:
    """Compute every value that a point of a sweep asks for, from a finite-element solution (None
    without finite elements) and from half-plane theory, which is solved here.

    Theory is solved on the surface points and instants of the finite elements; with `polygon` the
    loads go from instant to instant on straight lines, as theirs do. Theory alone, and that of
    prescribed displacements, is solved on its own surface points and instants of the steady cycle.
    `question` has the point's scene, the engines that run, and the names of the values (`figures`):
    keys of metrics (`METRICS`), which compare both engines, or names such as "fe.peak_pressure" and
    "error.stroke". Returns the values by name, with what they were taken from, reasons why a value
    is None, and uncertainties that the solutions state themselves.
    """
    # solve theory, and compare
    evaluation = Evaluation()
    has_metrics = bool(set(question.figures) & METRICS.keys())
    if "exact" in question.engines:
        evaluation.theory = _solve_theory(question, fe_solution, polygon=polygon)
    if has_metrics and evaluation.theory is not None and fe_solution is not None:
        evaluation.comparison = _compare(question, evaluation.theory, fe_solution, polygon=polygon)
    comparison = evaluation.comparison
    metrics_by_key = {metric.key: metric for metric in comparison.metrics} if comparison else {}

    # take each value
    for name in question.figures:
        stated_uncertainty = 0.0
        value: float | None = None
        reason = "this scene has no such metric"
        # a value of one engine, or an error, with the reason if it has none; else a metric, which
        # compares both engines
        if comparison is None or name not in METRICS:
            value, reason = _value_of_quantity(name, question.scene, fe_solution, evaluation.theory)
            if fe_solution is not None:
                stated_uncertainty = _uncertainty_of_edges(
                    name, question.scene, fe_solution, evaluation.theory
                )
        elif name in metrics_by_key:
            metric = metrics_by_key[name]
            value = metric.value
            reason = metric.note or "there is nothing to compare"
            stated_uncertainty = _stated_uncertainty(metric, comparison)
        evaluation.values[name] = value
        evaluation.stated_uncertainty[name] = stated_uncertainty
        if value is None:
            evaluation.notes[name] = reason
    return evaluation


def _solve_theory(
    question: Question, fe_solution: ContactSolution | None, *, polygon: bool
) -> ContactSolution:
    """Solve a point of a sweep by half-plane theory, with the fields (such as "pressure") that the
    requested values need. It is solved on the surface points and instants of the finite elements,
    with `polygon` under loads on straight lines between these instants.

    Without a finite-element solution, and where displacements are prescribed, it is solved on its
    own surface points and instants of the steady cycle. `question` holds the scene and the names of
    the values (`figures`). These are keys of metrics (`METRICS`), which need all fields, or a
    prefix and the name of one of the `QUANTITIES`, such as "fe.p0".
    """
    import semi_analytic

    fields: Sequence[str] = semi_analytic.FIELDS
    if not set(question.figures) & METRICS.keys():
        quantities = [QUANTITIES[name.partition(".")[2]] for name in question.figures]
        fields = sorted({field for quantity in quantities for field in quantity.fields})
    if fe_solution is None or question.scene.load.is_driven:
        # what finite bodies add to half-planes; None but for prescribed displacements
        effects = _effects_of_rig(question.scene)
        return semi_analytic.solve(question.scene, cycles="steady", fields=fields, effects=effects)
    return semi_analytic.solve(
        question.scene,
        x=fe_solution.x,
        time=fe_solution.time,
        straight_steps=polygon,
        fields=fields,
    )


def _compare(
    question: Question,
    theory: ContactSolution,
    fe_solution: ContactSolution,
    *,
    polygon: bool,
) -> Comparison:
    """Finite elements compared with theory for the metrics that a point of a sweep asks for.

    `polygon` says that `theory` has loads on straight lines between the instants. If not, such a
    solution is computed too where a metric or the error budget needs it. So are the compliances of
    the bodies, where displacements are compared.

    `question` has the names of the values that the point asks for (`figures`), among them keys of
    metrics (`METRICS`), and how their uncertainty is found: by a whole error budget with "budget".
    """
    from reports.comparison import compare
    from reports.comparison.budget import theory_on_steps

    metric_keys = set(question.figures) & METRICS.keys()
    needs_polygon = question.uncertainty == "budget" or bool(
        {"dissipation_polygon", "dissipation_step"} & metric_keys
    )
    theory_on_polygon = theory_on_steps(fe_solution) if needs_polygon and not polygon else None
    # _DISPLACEMENT_METRICS: keys of the metrics of displacement and approach
    compares_displacements = bool(metric_keys & _DISPLACEMENT_METRICS)
    effects = effects_between(theory, fe_solution) if compares_displacements else None
    return compare(theory, fe_solution, polygon_reference=theory_on_polygon, effects=effects)


def _stated_uncertainty(metric: Metric, comparison: Comparison) -> float:
    """Uncertainty that the finite-element solution states for a metric, or for the edges of contact
    or stick at the metric's instant over a_ref. The larger one counts; 0 where it states none. Here
    a_ref is the half-width by which lengths of the comparison are divided.
    """
    from reports.comparison.budget import uncertainty_of_edge

    stated_values = (metric.uncertainty or 0.0, uncertainty_of_edge(metric, comparison))
    return max((value for value in stated_values if math.isfinite(value)), default=0.0)


def _uncertainty_by_coarser_runs(
    question: Question,
    fe_solution: FiniteElementSolution,
    evaluation: Evaluation,
    notes: dict[str, str],
) -> Values:
    """Uncertainty of each value of a sweep's point, by its name + ".uncertainty". It is the sum of
    the changes that a coarser mesh, straight load increments and a farther far field make in the
    value. The increments count where theory runs too, and under bulk stress, tilt or a prescribed
    displacement; the far field, which is a half-disc of finite radius, counts for half-planes.

    The mesh is made twice as coarse at the surface and in the bulk; it contributes 1.64 times the
    change, or the uncertainty that the solution itself states where that is more. The far field
    contributes twice its change. A value that one of the runs lacks has no uncertainty (None), and
    `notes` gets the reason. Values of theory alone ("exact.") are left out.

    Parameters
    ----------
    question
        the point's scene with settings and the names of its values (`figures`)
    fe_solution
        the finite-element solution
    evaluation
        the values by it, with the uncertainty that it states itself
    notes
        gets the reason where a value has no uncertainty
    """
    # for each change its factor, and the values before and after it; the mesh comes first
    pairs_of_runs = _pairs_of_runs(question, fe_solution, evaluation)
    uncertainties: Values = {}
    for name in question.figures:
        if name.startswith("exact."):
            continue
        key = f"{name}.uncertainty"
        changes = []
        for factor, values, changed_values in pairs_of_runs:
            value = values[name]
            changed_value = changed_values[name]
            if value is not None and changed_value is not None:
                changes.append(factor * abs(value - changed_value))
        if len(changes) == len(pairs_of_runs):
            change_by_mesh, *further_changes = changes
            stated_uncertainty = evaluation.stated_uncertainty[name]
            uncertainties[key] = max(change_by_mesh, stated_uncertainty) + sum(further_changes)
        else:
            uncertainties[key] = None
            notes[key] = "one of the runs that it is taken from has no such value"
    return uncertainties


def _pairs_of_runs(
    question: Question, fe_solution: FiniteElementSolution, evaluation: Evaluation
) -> list[tuple[float, Values, Values]]:
    """Values of the runs between which the uncertainty of a sweep's point is taken. For each change
    of the settings: the factor by which the difference counts, the values before and after the
    change, by name. The first change is that of the mesh, further ones are those of the load
    increments and of the far field.

    `question` has the point's scene, its settings of mesh and solver, and what it asks for.
    `evaluation` has the values of `fe_solution`, with which no change was made. `mesh.growth` is
    the growth of the elements away from the contact, `mesh.far_radius` the radius of the half-disc
    that stands for a half-plane, over the half-width of contact.
    """
    import halfplane_fe
    from reports.comparison.budget import coarser_mesh_and_settings, settings_with_halved_steps

    # surface elements twice as large
    scene = question.scene
    coarse_mesh, coarse_solver = coarser_mesh_and_settings(question.mesh, question.solver, 2.0)

    def values_with_settings(mesh: MeshSettings, solver: SolverSettings = coarse_solver) -> Values:
        """All values of the point with other settings, by name."""
        # on the same length scales of contact, for which the mesh is made
        changed_solution = halfplane_fe.solve(scene, mesh, solver, scales=fe_solution.scales)
        return evaluate(question, changed_solution).values

    # the mesh, at the surface and in the bulk; _MESH_FACTOR: 1.64
    coarse_bulk = replace(coarse_mesh, growth=min(1.0, 2 * coarse_mesh.growth))
    pairs_of_runs = [(_MESH_FACTOR, evaluation.values, values_with_settings(coarse_bulk))]

    # The load increments, between which finite elements move the loads on straight lines.
    if _needs_halved_increments(scene):
        half_increments = values_with_settings(
            coarse_mesh, settings_with_halved_steps(coarse_solver)
        )
        pairs_of_runs.append((4 / 3, values_with_settings(coarse_mesh), half_increments))
    elif "exact" in question.engines:
        values_on_polygon = evaluate(question, fe_solution, polygon=True).values
        pairs_of_runs.append((1.0, evaluation.values, values_on_polygon))

    # the far field; _FAR_FIELD_FACTOR: 2
    if _has_far_field_to_double(question):
        # Both with the bulk as it is: a far field beyond a coarse bulk shows what the bulk does.
        far_mesh = replace(coarse_mesh, far_radius=2 * coarse_mesh.far_radius)
        pairs_of_runs.append(
            (_FAR_FIELD_FACTOR, values_with_settings(coarse_mesh), values_with_settings(far_mesh))
        )
    return pairs_of_runs


def _needs_halved_increments(scene: Scene) -> bool:
    """Whether the error of the load increments is taken from halved increments (second order). Else
    it is taken from theory on the polygon of the increments. Theory has no such answer for every
    scene under bulk stress or tilt, with unequal sides of the profile, or with a prescribed
    tangential displacement (`is_driven`).
    """
    return bool(scene.unsymmetric or scene.load.is_driven)


def _has_far_field_to_double(question: Question) -> bool:
    """Whether a body of the point's scene is a half-plane, for which a half-disc stands whose
    radius can be doubled: it is at most 500 half-widths of contact.
    """
    bodies = question.scene.bodies
    has_half_plane = "half_plane" in (bodies.lower.kind, bodies.upper.kind)
    return has_half_plane and question.mesh.far_radius <= 500


def _silent_stage(_name: str) -> Any:
    """A stage whose progress nobody sees."""
    return nullcontext(lambda *_: None)


def _uncertainty_by_budget(
    question: Question, evaluation: Evaluation, notes: dict[str, str]
) -> Values:
    """Idealisation error of each metric of a sweep's point by a full error budget: the difference
    of finite elements from theory that is left when all numerical errors are subtracted. It stands
    under the metric's name + ".idealisation", its uncertainty under the name + ".uncertainty".
    Without a budget both are None; where there is no uncertainty, `notes` gets the reasons.

    The numerical errors are measured by further runs, on coarser meshes and with other load
    increments and far fields (half-discs of finite radius in place of half-planes). `question` has
    the settings of mesh and solver; `evaluation` has the comparison of both engines, and the
    metrics' values by name.
    """
    from reports.comparison.budget import error_budget, solve_refinements

    comparison = evaluation.comparison
    assert comparison is not None
    # the further runs; progress is not shown
    refinements = solve_refinements(comparison, question.mesh, question.solver, _silent_stage)
    # 1.0: CPU seconds of the run, which do not matter here
    budgets = error_budget(comparison, refinements, 1.0).budgets
    budget_by_key = {budget.metric.key: budget for budget in budgets}
    errors_and_uncertainties: Values = {}
    # of a budget, `rest_of_error` is the idealisation error; `terms` are the numerical errors
    for name in evaluation.values:
        budget = budget_by_key.get(name)
        errors_and_uncertainties[f"{name}.idealisation"] = (
            None if budget is None else budget.rest_of_error
        )
        errors_and_uncertainties[f"{name}.uncertainty"] = (
            None if budget is None else budget.uncertainty
        )
        if budget is None or budget.uncertainty is None:
            error_terms = budget.terms if budget else ()
            reasons = [
                f"{term.name}: {term.how_measured}" for term in error_terms if not term.is_measured
            ]
            notes[f"{name}.uncertainty"] = "; ".join(reasons) or "the budget has no such metric"
    return errors_and_uncertainties
