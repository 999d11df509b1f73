"""From a scene with a long time series to a ContactSolution: rows through the stack, fields at chosen instants only."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import ContactSolution, Record, Scene, Work, freeze
from semi_analytic.bookkeeping import neglected_coupling, not_evaluated, versions
from semi_analytic.contact import Contact, contact_of
from semi_analytic.elasticity import composite_modulus
from semi_analytic.errors import field_errors
from semi_analytic.evaluation import grids_of, series_of
from semi_analytic.proofs import certificates, ending
from semi_analytic.question import folded, spread
from semi_analytic.rounding import rounding_of_slip
from semi_analytic.route import Cycles
from semi_analytic.time_series import Series, calendar_of, follow, instants_of

Array = NDArray[np.float64]

_POINTWISE = frozenset(("pressure", "shear", "slip", "state"))


@dataclass(frozen=True, eq=False)
class Asked:
    """What is to be evaluated, as `evaluation.Asked`."""

    contact: Contact
    modulus: float
    time: Array
    x: Array
    distance: Array
    fold: NDArray[np.int64]
    fields: frozenset[str]


def solve_rows(scene: Scene, x: Array | None, time: Array | None, cycles: Cycles, fields: frozenset[str]) -> ContactSolution:
    """The answer for a series that is followed row by row.

    Where `time` is None it is given at every row; at about 400 of them where pointwise fields are wanted, which a note says.
    """
    started = clock.perf_counter()
    contact, modulus = contact_of(scene.profile, scene.material), composite_modulus(scene.material)
    calendar = calendar_of(scene, time, cycles)
    few = not fields.isdisjoint(_POINTWISE)
    instants = instants_of(calendar, cycles, few) if time is None else time
    thinned = len(instants_of(calendar, cycles, False)) - len(instants) if time is None else 0
    largest = float(np.max(calendar.rows[:, 1]))
    if x is None:
        x = spread(1.05 * float(contact.half_width(largest))) if few or "dissipation_density" in fields else np.zeros(1)
    distance, fold = folded(x)
    asked = Asked(contact, modulus, instants, x, distance, fold, fields)
    series = follow(calendar, scene.friction.coefficient, contact, instants, fields, distance)
    followed = clock.perf_counter()
    lines = series_of(asked, series.snapshot)
    grids = grids_of(asked, series.snapshot, lines["contact_half_width"], lines["stick_half_width"])
    seconds = {"history": followed - started, "fields": clock.perf_counter() - followed}
    errors = field_errors(asked, series.snapshot, lines, grids) | _work_errors(fields, series)
    settings = {"cycles": cycles, "fields": sorted(fields), "straight_steps": False}
    return _solution(scene, asked, series, lines, grids, seconds, settings, thinned, errors)


def _work_errors(fields: frozenset[str], series: Series) -> dict[str, float]:
    """Estimates of dissipation over itself and of the density over its largest value; for closed forms only that of rounding."""
    last = series.passes[series.calendar.covered[-1]]
    if "dissipation" not in fields or not last.work:
        return {}
    # Every row rounds the fronts again: 5 % at 1e-12 of f P in 2,400 rows, where four lines have 1e-5.
    rounding = rounding_of_slip(last.deepest / float(np.max(series.calendar.rows[:, 1])))
    error = last.doubt / last.work + 3 * math.sqrt(last.slips) * rounding
    if not error:
        return {}
    return {name: error for name in ("dissipation", "dissipation_density") if name in fields}


def _solution(
    scene: Scene,
    asked: Asked,
    series: Series,
    lines: Mapping[str, Array],
    grids: Mapping[str, NDArray[Any]],
    seconds: Mapping[str, float],
    settings: Mapping[str, Any],
    thinned: int,
    errors: Mapping[str, float],
) -> ContactSolution:
    factor = 2 * scene.friction.coefficient / (math.pi * asked.modulus)
    calendar, last = series.calendar, series.passes[series.calendar.covered[-1]]
    wanted = "dissipation" in asked.fields
    each = np.array([factor * series.passes[k].work if wanted else math.nan for k in calendar.covered])
    density = factor * last.density if "dissipation_density" in asked.fields else np.full(len(asked.distance), np.nan)
    stick = float(asked.contact.half_width(max(last.least, 0.0)))
    arrays: dict[str, Any] = {**{name: freeze(values) for name, values in lines.items()}, **grids}
    return ContactSolution(
        engine="semi_analytic",
        scene=scene,
        time=freeze(asked.time),
        x=freeze(asked.x),
        dissipation=float(each[-1]),
        loop_work=math.nan,
        cycle_dissipation=freeze(each),
        dissipation_density=freeze(density[asked.fold]),
        permanent_stick_half_width=stick if stick > 0 else math.nan,
        steady_from=calendar.steady_from,
        record=replace(_record(scene, asked, series, factor, grids, thinned), errors=errors),
        work=_work(scene, asked, series, seconds),
        settings=settings,
        versions=versions(),
        **arrays,
    )


def _record(scene: Scene, asked: Asked, series: Series, factor: float, grids: Mapping[str, NDArray[Any]], thinned: int) -> Record:
    snapshot, friction, calendar = series.snapshot, scene.friction.coefficient, series.calendar
    balance = series.held + snapshot.direction * friction * snapshot.slipped - snapshot.force
    followed, cycles = "the rows were followed to their end", len(calendar.tables) - 1
    termination, message = ending(followed, calendar.period, calendar.steady_from, cycles)
    return Record(
        converged=True,
        termination=termination,
        message=message,
        iterations=freeze(np.zeros(len(asked.time)), np.int64),
        certificates=certificates(friction, snapshot.load, balance, grids, asked.fields),
        energy={"dissipation": freeze(factor * series.increments)} if len(series.increments) else {},
        notes=tuple(_notes(scene, asked, series, thinned)),
    )


def _notes(scene: Scene, asked: Asked, series: Series, thinned: int) -> Iterator[str]:
    yield from neglected_coupling(scene.material)
    if series.calendar.period is not None and "dissipation" in asked.fields:
        yield "no closed integral of Q dU is taken over a long series: the dissipation was found in one way only"
    if thinned:
        yield f"with pointwise fields the answer is given at {len(asked.time)} rows, {thinned} were left out; `time` chooses others"


def _work(scene: Scene, asked: Asked, series: Series, seconds: Mapping[str, float]) -> Work:
    calendar, passes = series.calendar, series.passes
    solved = len(calendar.tables) - 1 if calendar.period is not None else 1
    copies = max(scene.cycles, len(calendar.covered)) - solved
    skipped = not_evaluated(asked.fields, len(asked.time), calendar.steady_from, copies)
    slips = sum(each.slips for each in passes)
    counts = {
        "instants": len(asked.time),
        "points": len(asked.x),
        "points_evaluated": len(asked.distance),
        "rows": len(calendar.rows),
        "slips": slips,
        "cycles_solved": solved,
        "pieces_alive": max(each.alive for each in passes),
        "pieces_dropped": sum(each.dropped for each in passes),
        "curves": sum(len(each.curves) for each in passes),
        "slip_quadratures": slips if "dissipation" in asked.fields else 0,
    }
    return Work(counts, skipped, dict(seconds))
