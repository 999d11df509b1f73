"""From a scene to a ContactSolution: which fields at which points and instants, and a record of what was done and what was not."""

from __future__ import annotations

import math
import platform
import time as clock
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib import metadata
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from scenes import ContactSolution, InputError, Record, Scene, SurfaceState, Work, freeze
from semi_analytic.contact import Contact, contact_of
from semi_analytic.dissipation import closed_integral, global_dissipation, pointwise_dissipation
from semi_analytic.elasticity import composite_modulus, coupling_constant
from semi_analytic.fields import Integrals
from semi_analytic.history import Span
from semi_analytic.memory import pieces, value_on
from semi_analytic.quadrature import NODES
from semi_analytic.route import Cycles, Route, default_times, locate, own_route, straight_route
from semi_analytic.snapshot import Snapshot, take

Array = NDArray[np.float64]

FIELDS = ("pressure", "shear", "slip", "state", "rigid_shift", "rigid_approach", "dissipation_density", "dissipation")
"""The fields that can be asked for one by one."""

_POINTS = 200


@dataclass(frozen=True, eq=False)
class Question:
    """What is to be evaluated: instants sorted into spans, points folded onto x >= 0.

    Attributes
    ----------
    contact, modulus, friction : normal contact, E*, f
    route : the solved history
    time : (n,) instants as asked for
    span, local : (n,) number of the span, time of its leg
    x : (m,) points as asked for
    distance, fold : (k,) different |x|, (m,) where each x finds its own
    fields : what is wanted
    """

    contact: Contact
    modulus: float
    friction: float
    route: Route
    time: Array
    span: NDArray[np.int64]
    local: Array
    x: Array
    distance: Array
    fold: NDArray[np.int64]
    fields: frozenset[str]

    def snapshot(self) -> Snapshot:
        """The memory curves at the instants, in their order."""
        order = np.argsort(self.span, kind="stable")
        numbers, starts = np.unique(self.span[order], return_index=True)
        spans = self.route.history.spans
        sorted_times = np.split(self.local[order], starts[1:])
        taken = take((spans[number], times) for number, times in zip(numbers, sorted_times, strict=True))
        back = np.argsort(order)
        columns = ("time", "load", "force", "slipped", "direction", "which")
        return replace(taken, **{name: getattr(taken, name)[back] for name in columns})


def solve(
    scene: Scene,
    x: ArrayLike | None = None,
    time: ArrayLike | None = None,
    *,
    cycles: Cycles = "all",
    fields: Iterable[str] = FIELDS,
    straight_steps: bool = False,
) -> ContactSolution:
    """The half-plane answer to a scene, exact to rounding at every point and instant asked for.

    Parameters
    ----------
    scene : the question
    x : (n_points,) contact points [length]; 200 across the largest contact and a little beyond if None
    time : (n_steps,) instants, in any order; about 400 a cycle, all events among them, if None
    cycles : "all" (the way in and every cycle up to the first steady one) or "steady" (that one only); no effect where
        `time` is given
    fields : names out of `FIELDS`; the others come back as NaN (state: open) and are counted in `work.skipped`
    straight_steps : follow straight lines between the given times (ascending) instead of the scene's path: the polygon that a
        step-by-step solver saw, so that its step error can be told apart

    Returns ------- ContactSolution. Its dissipations are those of the last whole cycle within `time`; where `time` holds
    none, or is not given, those of the steady cycle (of cycle number `scene.cycles` if none is steady before). Cycles after
    the steady one are looked up, not solved.

    Raises
    ------
    InputError
        For an unknown field, a time outside the path, a profile that this engine does not know.
    InadmissibleLoadError
        For gross sliding or separation anywhere in the path, with the instant and the loads.

    >>> from scenes import load_scene
    >>> solution = solve(load_scene("hertz-normal"), x=[0.0], time=[1.0], fields=("pressure",))
    >>> round(solution.pressure.item() / (2 * 90.62286500739786 / math.pi), 12)  # 2 P/(pi a) with a = 1
    1.0
    """
    started = clock.perf_counter()
    question = _question(scene, x, time, cycles, _checked(fields), straight_steps)
    marched = clock.perf_counter()
    snapshot = question.snapshot()
    series, grids = _series(question, snapshot), _grids(question, snapshot)
    evaluated = clock.perf_counter()
    work_done = _dissipations(question)
    seconds = {
        "history": marched - started,
        "fields": evaluated - marched,
        "dissipation": clock.perf_counter() - evaluated,
    }
    everything: dict[str, NDArray[Any]] = {**series, **grids, **work_done.arrays}
    return ContactSolution(
        engine="semi_analytic",
        scene=scene,
        time=freeze(question.time),
        x=freeze(question.x),
        dissipation=work_done.last,
        loop_work=work_done.second_route,
        permanent_stick_half_width=_permanent_stick(question),
        steady_from=question.route.history.steady_from,
        record=_record(scene, question, snapshot, everything, work_done),
        work=_work(scene, question, work_done, seconds),
        settings={"cycles": cycles, "fields": sorted(question.fields), "straight_steps": straight_steps},
        versions=_versions(),
        **{name: freeze(values, np.int8 if name == "state" else float) for name, values in everything.items()},
    )


def _checked(fields: Iterable[str]) -> frozenset[str]:
    wanted = frozenset(fields)
    unknown = sorted(wanted - set(FIELDS))
    if unknown:
        raise InputError(f"fields: {unknown[0]!r} is not among {', '.join(FIELDS)}")
    return wanted


def _question(
    scene: Scene, x: ArrayLike | None, time: ArrayLike | None, cycles: Cycles, fields: frozenset[str], straight: bool
) -> Question:
    """Everything but the evaluation."""
    if cycles not in ("all", "steady"):
        raise InputError(f"cycles: {cycles!r} is neither 'all' nor 'steady'")
    if straight and time is None:
        raise InputError("straight_steps: give the times between which the steps are straight")
    contact, path, friction = contact_of(scene.profile, scene.material), scene.load.path(), scene.friction.coefficient
    asked = None if time is None else _vector(time, "time")
    if straight and asked is not None:
        route = straight_route(path, friction, asked)
    else:
        route = own_route(path, friction, scene.cycles, asked)
    if cycles == "steady" and asked is None:
        route = replace(route, covered=route.covered[-1:])
    instants = default_times(route, cycles) if asked is None else asked
    span, local = locate(route, instants)
    largest = max(max(s.begin.normal, s.end.normal) for s in route.history.spans)
    edge = 1.05 * float(contact.half_width(largest))
    points = _spread(edge) if x is None else _vector(x, "x")
    distance, fold = np.unique(np.abs(points), return_inverse=True)
    modulus = composite_modulus(scene.material)
    return Question(contact, modulus, friction, route, instants, span, local, points, distance, fold, fields)


def _spread(edge: float) -> Array:
    """Points from -edge to edge, mirrored to the last digit."""
    right = np.linspace(edge / (_POINTS - 1), edge, _POINTS // 2)
    return np.concatenate([-right[::-1], right])


def _vector(values: ArrayLike, name: str) -> Array:
    array = np.array(values, dtype=float)
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)):
        raise InputError(f"{name}: a list of finite numbers is needed, not an array of shape {array.shape}")
    return array


def _series(question: Question, snapshot: Snapshot) -> dict[str, Array]:
    """Loads, half-widths, edges and rigid movements: (n,) or (n, 2)."""
    contact, fields = question.contact, question.fields
    factor, nothing = 2 / (math.pi * question.modulus), np.full(len(question.time), np.nan)
    front = snapshot.load - snapshot.slipped
    half, stick = contact.half_width(snapshot.load), contact.half_width(front)
    stick = np.where((front <= 0) & (stick == 0), np.nan, stick)
    shift = Integrals(contact, np.zeros(1), "shift").over(snapshot)[:, 0] if "rigid_shift" in fields else nothing
    return {
        "normal_load": snapshot.load,
        "tangential_load": snapshot.force,
        "rigid_shift": factor * shift,
        "rigid_approach": factor * contact.log_distance(snapshot.load) if "rigid_approach" in fields else nothing,
        "contact_half_width": half,
        "stick_half_width": stick,
        "contact_edges": half[:, None] * np.array([-1.0, 1.0]),
        "stick_edges": stick[:, None] * np.array([-1.0, 1.0]),
    }


def _grids(question: Question, snapshot: Snapshot) -> dict[str, NDArray[Any]]:
    """pressure, shear, slip, state: (n, m)."""
    contact, x = question.contact, question.distance
    nothing = np.full((len(question.time), len(x)), np.nan)
    grids: dict[str, NDArray[Any]] = dict.fromkeys(("pressure", "shear", "slip"), nothing)
    grids["state"] = np.full(nothing.shape, SurfaceState.OPEN, dtype=np.int8)
    if "pressure" in question.fields:
        grids["pressure"] = contact.pressure(x, snapshot.load[:, None])
    if "shear" in question.fields:
        grids["shear"] = Integrals(contact, x, "shear").over(snapshot)
    if "slip" in question.fields:
        grids["slip"] = 2 / (math.pi * question.modulus) * Integrals(contact, x, "slip").over(snapshot)
    if "state" in question.fields:
        grids["state"] = _states(contact, x, snapshot)
    return {name: values[:, question.fold] for name, values in grids.items()}


def _states(contact: Contact, x: Array, snapshot: Snapshot) -> NDArray[np.int8]:
    half = contact.half_width(snapshot.load)[:, None]
    stick = contact.half_width(snapshot.load - snapshot.slipped)[:, None]
    names = (SurfaceState.SLIP_REVERSE, SurfaceState.STICK, SurfaceState.SLIP_FORWARD)
    sliding = np.array(names, dtype=np.int8)[snapshot.direction + 1][:, None]
    inner = np.where(x > stick, sliding, np.int8(SurfaceState.STICK))
    return np.where((x <= half) & (snapshot.load[:, None] > 0), inner, np.int8(SurfaceState.OPEN))


@dataclass(frozen=True, eq=False)
class Dissipations:
    """Friction work of the cycles, the last one by a second route too, and how many quadratures it took."""

    last: float
    second_route: float
    arrays: Mapping[str, Array]
    slip_spans: int
    stick_spans: int


def _dissipations(question: Question) -> Dissipations:
    route, contact, modulus = question.route, question.contact, question.modulus
    cycles, last = route.history.cycles, route.covered[-1]
    density, each, second = np.full(len(question.distance), np.nan), np.full(len(route.covered), np.nan), math.nan
    used: list[Span] = []
    if "dissipation_density" in question.fields:
        density = pointwise_dissipation(contact, modulus, cycles[last], question.distance).total
        used.extend(cycles[last])
    if "dissipation" in question.fields:
        works = {number: float(global_dissipation(contact, modulus, cycles[number]).total) for number in set(route.covered)}
        each = np.array([works[number] for number in route.covered])
        used.extend(span for number in works for span in cycles[number])
        steady = route.history.steady_from
        if steady is not None and last >= steady:
            second = closed_integral(contact, modulus, cycles[last]) if works[last] else 0.0
    slipping = sum(span.direction != 0 for span in used)
    arrays = {"dissipation_density": density[question.fold], "cycle_dissipation": each}
    return Dissipations(float(each[-1]), second, arrays, slipping, len(used) - slipping)


def _permanent_stick(question: Question) -> float:
    """Half-width of what sticks through the whole last cycle; NaN if nothing does."""
    fronts: list[float] = []
    for span in question.route.history.cycles[question.route.covered[-1]]:
        ends = np.array([span.begin.time, span.end.time])
        fronts.extend((span.leg.loads(ends)[0] - span.slipped(ends)).tolist())
    least = max(min(fronts), 0.0)
    half = float(question.contact.half_width(least))
    return half if half > 0 else math.nan


def _record(
    scene: Scene, question: Question, snapshot: Snapshot, arrays: Mapping[str, NDArray[Any]], work_done: Dissipations
) -> Record:
    tiny = np.finfo(float).tiny
    force = max(question.friction * float(np.max(snapshot.load)), tiny)
    certificates = {"tangential_balance": freeze(np.abs(_mismatch(snapshot)) / force)}
    if {"pressure", "shear"} <= question.fields:
        limit = question.friction * arrays["pressure"]
        beyond = np.max(np.abs(arrays["shear"]) - limit, axis=1, initial=0.0)
        certificates["cone"] = freeze(beyond / max(float(np.max(limit)), tiny))
    steady = question.route.history.steady_from
    if question.route.period is None:
        message, termination = "the path was followed to its end", "end of path"
    elif steady is None:
        message, termination = f"no steady cycle among the first {len(question.route.history.cycles)}", "end of path"
    else:
        message, termination = f"cycle {steady} ends in the state it started from", "steady"
    return Record(
        converged=True,
        termination=termination,
        message=message,
        iterations=freeze(np.zeros(len(question.time)), np.int64),
        certificates=certificates,
        notes=tuple(_notes(scene, question, work_done)),
    )


def _mismatch(snapshot: Snapshot) -> Array:
    """M(P) - Q, (n,): what the pieces carry less what is applied."""
    held = snapshot.direction * snapshot.friction * snapshot.slipped
    for piece, here in snapshot.groups():
        held[here] += value_on(piece, (snapshot.load - snapshot.slipped)[here])
    return held - snapshot.force


def _notes(scene: Scene, question: Question, work_done: Dissipations) -> Iterator[str]:
    beta = coupling_constant(scene.material)
    if beta != 0:
        yield f"Dundurs' beta = {beta:.6g}: the bodies are unlike, and the coupling of normal and shear tractions is neglected"
    if not math.isfinite(work_done.second_route) and "dissipation" in question.fields and question.route.period is not None:
        yield "the last cycle is not steady: no closed integral of Q dU to compare the dissipation with"


def _work(scene: Scene, question: Question, work_done: Dissipations, seconds: Mapping[str, float]) -> Work:
    history = question.route.history
    alive = max(sum(1 for _ in pieces(span.active)) for span in history.spans)
    skipped = {name: (len(question.time), "not asked for") for name in FIELDS if name not in question.fields}
    if history.steady_from is not None:
        copies = max(scene.cycles, len(question.route.covered)) - len(history.cycles)
        if copies > 0 and not question.route.straight:
            skipped["cycles"] = (copies, f"copies of cycle {history.steady_from}, which is steady")
    if work_done.stick_spans:
        skipped["quadratures"] = (work_done.stick_spans, "full stick: nothing slips")
    counts = {
        "instants": len(question.time),
        "points": len(question.x),
        "points_evaluated": len(question.distance),
        "spans": len(history.spans),
        "cycles_solved": len(history.cycles),
        "pieces_alive": alive,
        "slip_quadratures": work_done.slip_spans,
        "quadrature_nodes": work_done.slip_spans * NODES,
    }
    return Work(counts, skipped, dict(seconds))


def _versions() -> dict[str, str]:
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "halfplane": _version_of("halfplane"),
    }


def _version_of(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
