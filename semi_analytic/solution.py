"""From a scene to a ContactSolution: the fields at the points and instants that are asked for, and the dissipations."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import ContactSolution, Scene, freeze
from scenes.frozen import validated
from semi_analytic.bookkeeping import Dissipations, record_of, versions, work_of
from semi_analytic.contact import bends_anywhere
from semi_analytic.corners import has_corners
from semi_analytic.errors import dissipation_error, field_errors
from semi_analytic.evaluation import grids_of, series_of
from semi_analytic.friction_work import closed_integral_and_rounding, global_dissipation, pointwise_dissipation
from semi_analytic.history import Span
from semi_analytic.question import FIELDS, Question, arrays_of, ask, checked
from semi_analytic.rounding import PROMISED, rounding_of_shift, rounding_of_slip, rounding_of_work, slipped_share
from semi_analytic.route import Cycles
from semi_analytic.row_solution import solve_rows
from semi_analytic.steady_ellipse import Ellipses, density_of, dissipation_of, ellipses_of
from semi_analytic.time_series import is_long

Array = NDArray[np.float64]

# Rounding of the closed integral of Q dU over the dissipation, above which it is no second route any more.
_TOO_ROUGH = 1e-2


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

    Returns
    -------
    ContactSolution. Its dissipations are those of the last whole cycle within `time`; where `time` holds none, or is not given,
    those of the steady cycle (of cycle number `scene.cycles` if none is steady before). Cycles after the steady one are looked
    up, not solved. A time series of more than 1,000 rows is followed row by row: without `time` the answer is given at every
    row, at about 400 of them with pointwise fields; a million rows take some seconds and memory for the rows asked for, W(x) of
    them at 200 points half a minute to minutes: leave "dissipation_density" out of `fields` where it is not wanted.

    Raises
    ------
    InputError
        For a scene that does not pass its own check, an unknown field, a time outside the path, a profile that this engine does not
        know.
    InadmissibleLoadError
        For gross sliding or separation anywhere in the path, with the instant and the loads.

    >>> from scenes import load_scene
    >>> solution = solve(load_scene("hertz-normal"), x=[0.0], time=[1.0], fields=("pressure",))
    >>> round(solution.pressure.item() / (2 * 90.62286500739786 / math.pi), 12)  # 2 P/(pi a) with a = 1
    1.0
    """
    scene = validated(scene, Scene)
    if is_long(scene) and not straight_steps:
        return solve_rows(scene, *arrays_of(x, time, cycles), cycles, checked(fields))
    started = clock.perf_counter()
    question = ask(scene, x, time, cycles, fields, straight_steps)
    marched = clock.perf_counter()
    snapshot = question.snapshot()
    series = series_of(question, snapshot)
    grids = grids_of(question, snapshot, series["contact_half_width"], series["stick_half_width"])
    evaluated = clock.perf_counter()
    work_done = _dissipations(question)
    errors = field_errors(question, snapshot, series, grids)
    if "slip" in question.fields and (rounding := 8 * rounding_of_slip(slipped_share(question.route.history.spans))):
        errors["slip"] = errors.get("slip", 0.0) + rounding
    if "rigid_shift" in question.fields and (rounding := _rounding_of_shift(question, series)):
        errors["rigid_shift"] = rounding
    errors |= {name: doubt for name, doubt in work_done.doubts.items() if doubt and name in (*question.fields, "loop_work")}
    seconds = {
        "history": marched - started,
        "fields": evaluated - marched,
        "dissipation": clock.perf_counter() - evaluated,
    }
    arrays: dict[str, Any] = {**{name: freeze(values) for name, values in {**series, **work_done.arrays}.items()}, **grids}
    return ContactSolution(
        engine="semi_analytic",
        scene=scene,
        time=freeze(question.time),
        x=freeze(question.x),
        dissipation=work_done.last,
        loop_work=work_done.second_route,
        permanent_stick_half_width=_permanent_stick(question),
        steady_from=question.route.history.steady_from,
        record=record_of(scene, question, snapshot, grids, errors),
        work=work_of(scene, question, work_done, seconds),
        settings={"cycles": cycles, "fields": sorted(question.fields), "straight_steps": straight_steps},
        versions=versions(),
        **arrays,
    )


def _rounding_of_shift(question: Question, series: dict[str, Array]) -> float:
    shifts = math.pi * question.modulus / 2 * series["rigid_shift"]
    return rounding_of_shift(question.friction, question.contact.log_distance(series["normal_load"]), shifts)


def _dissipations(question: Question) -> Dissipations:
    route, contact, modulus = question.route, question.contact, question.modulus
    cycles, last = route.history.cycles, route.covered[-1]
    density, each, second = np.full(len(question.distance), np.nan), np.full(len(route.covered), np.nan), math.nan
    used: list[Span] = []
    doubts: dict[str, float] = {}
    if "dissipation_density" in question.fields:
        density, doubts["dissipation_density"] = _density_of_cycle(question, last)
        used.extend(cycles[last])
    if "dissipation" in question.fields:
        works = {number: _work_of_cycle(question, number) for number in set(route.covered)}
        each = np.array([works[number][0] for number in route.covered])
        doubts["dissipation"] = max(doubt for _, doubt in works.values())
        used.extend(span for number in works for span in cycles[number])
        steady = route.history.steady_from
        if steady is not None and last >= steady:
            second = _second_route(question, last, works[last][0])
        own = doubts["dissipation"]
        doubts["dissipation"] += dissipation_error(contact, cycles[last], modulus, float(each[-1]), second)
        # Of the two routes W keeps more digits where slip is tiny: what they differ by is the error of the other one.
        apart = own + abs(second / float(each[-1]) - 1) if math.isfinite(second) and each[-1] > 0 else 0.0
        doubts["loop_work"] = apart if apart > PROMISED else 0.0
        doubts["dissipation_density"] = doubts.get("dissipation_density", 0.0) + doubts["dissipation"]
    slipping = sum(span.direction != 0 for span in used)
    arrays = {"dissipation_density": density[question.fold], "cycle_dissipation": each}
    return Dissipations(float(each[-1]), second, arrays, slipping, len(used) - slipping, doubts)


def _second_route(question: Question, number: int, work: float) -> float:
    """Closed integral of Q dU of a solved cycle that dissipates `work`; NaN where less than two digits of it are left."""
    if not work:
        return 0.0
    spans = question.route.history.cycles[number]
    value, rounding = closed_integral_and_rounding(question.contact, question.modulus, spans)
    return value if rounding < _TOO_ROUGH * work else math.nan


def _work_of_cycle(question: Question, number: int) -> tuple[float, float]:
    """Friction work of a solved cycle and its relative error; a steady ellipse by formulas that keep their digits, however small
    the slip.
    """
    if _is_smooth_loop(question, number):
        forward, reverse = dissipation_of(_loop(question), question.contact)
        return _unit_of_work(question) * float(forward[0] + reverse[0]), 0.0
    spans = question.route.history.cycles[number]
    split = global_dissipation(question.contact, question.modulus, spans)
    return float(split.total), (float(split.error / split.total) if split.error else 0.0) + rounding_of_work(spans)


def _density_of_cycle(question: Question, number: int) -> tuple[Array, float]:
    """W(x) of a solved cycle, (k,), and its error over its largest value."""
    x = question.distance
    # One rule a phase is not enough where P may hardly grow: spans are halved until they settle.
    if _is_smooth_loop(question, number) and not bends_anywhere(question.contact):
        forward, reverse = density_of(_loop(question).take(np.zeros(len(x), dtype=int)), question.contact, x)
        return _unit_of_work(question) * (forward + reverse), 0.0
    spans = question.route.history.cycles[number]
    split = pointwise_dissipation(question.contact, question.modulus, spans, x)
    worst = float(np.max(split.error))
    return split.total, (worst / float(np.max(split.total)) if worst else 0.0) + rounding_of_work(spans)


def _is_smooth_loop(question: Question, number: int) -> bool:
    """Whether a cycle is the steady state of an ellipse whose work the formulas of `steady_ellipse` give."""
    return question.route.is_loop(number) and question.friction > 0 and not has_corners(question.contact)


def _loop(question: Question) -> Ellipses:
    leg = question.route.loop
    assert leg is not None
    loads = (leg.mean[0], leg.amplitude[0], leg.amplitude[1], leg.phase, question.friction)
    return ellipses_of(*(np.array([value]) for value in loads))


def _unit_of_work(question: Question) -> float:
    return 2 / (math.pi * question.modulus) * question.friction**2


def _permanent_stick(question: Question) -> float:
    """Half-width of what sticks through the whole last cycle; NaN if nothing does."""
    fronts: list[float] = []
    for span in question.route.history.cycles[question.route.covered[-1]]:
        ends = np.array([span.begin.time, span.end.time])
        fronts.extend((span.leg.loads(ends)[0] - span.slipped(ends)).tolist())
    least = max(min(fronts), 0.0)
    half = float(question.contact.half_width(least))
    return half if half > 0 else math.nan
