"""From a foreign result to a ContactSolution: its place on the load path, what follows from its own fields, what it lacks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.comparison.laws import DERIVED
from reports.comparison.metrics import WHOLE_CYCLE
from reports.scoring.guesses import guessed, oddities
from reports.scoring.history import History, matched
from reports.scoring.mapping import Mapping
from reports.scoring.surface import SurfaceResult
from reports.scoring.zones import Zones, zones
from scenes import ContactSolution, InputError, Record, Scene, Work, freeze

Array = NDArray[np.float64]
LACKING = "not in the result"
# Instants of a cycle below which the work of friction by the trapezoidal rule means nothing.
FEWEST = 8


def contact_solution(
    result: SurfaceResult, mapping: Mapping, whole: ContactSolution, *, sure_of_times: bool = True
) -> tuple[ContactSolution, tuple[str, ...]]:
    """The solution that `result` amounts to, and what was guessed on the way, in sentences.

    Nothing is filled in: what the result does not hold is NaN, named in `work.skipped`, and left out of the comparison. Worked
    out from its own fields, and said so in the notes, are states, edges, and of a whole cycle with slip the work of friction.
    `whole` is the `whole_path` of the scene that it answers.

    Raises
    ------
    InputError
        For a history that is not the scene's.
    """
    scene = whole.scene
    result, guesses = guessed(result, mapping, whole)
    history = matched(result, scene, sure_of_times=sure_of_times)
    found = zones(result, scene.friction.coefficient, history.time)
    steps = _last_cycle(scene, history)
    density, notes = _dissipation(result, steps)
    skipped = _skipped(result, history, steps, density)
    oddly = (*_sign_of_shear(history, mapping), *oddities(result, history.tangential_load, scene))
    stated = result.normal_load is not None and result.tangential_load is not None
    said = (*result.notes, *history.notes, *found.notes, *notes, *([] if stated else ["P and Q are the scene's at its instants"]))
    solution = ContactSolution(
        engine=result.code or Path(result.source).name,
        scene=scene,
        **_series(result, history, found),
        x=result.x,
        pressure=result.pressure,
        shear=result.shear,
        state=freeze(found.state, np.int8),
        slip=freeze(np.full_like(result.pressure, np.nan) if result.slip is None else result.slip),
        dissipation_density=freeze(density),
        dissipation=float(np.trapezoid(density, result.x)),
        cycle_dissipation=freeze([np.trapezoid(density, result.x)]),
        permanent_stick_half_width=permanent_stick(found.stick_edges[steps]),
        steady_from=None,
        record=Record(True, "end of path", f"read from {result.source}", freeze(np.zeros(len(history.time)), np.int64), notes=said),
        work=Work({"instants": len(history.time), "points": len(result.x)}, skipped),
        settings=_settings(result, mapping, stated=stated),
    )
    return solution, (*guesses, *([history.guess] if history.guess else []), *oddly)


def _sign_of_shear(history: History, mapping: Mapping) -> Iterator[str]:
    """What nothing in the file can tell, unless the mapping does."""
    if history.either_sign and mapping.signs.shear is None:
        yield (
            "the shear acts on the lower body: its instants were found from the shear itself, and the scene's path fits it turned "
            "round as well (signs.shear, or columns of P and Q, say it for certain)"
        )


def _series(result: SurfaceResult, history: History, found: Zones) -> dict[str, Any]:
    """What has one figure, or two edges, at each instant."""
    nothing = np.full(len(history.time), np.nan)
    stated = result.normal_load is not None and result.tangential_load is not None
    series = {
        "time": history.time,
        "normal_load": result.normal_load if stated else history.normal_load,
        "tangential_load": result.tangential_load if stated else history.tangential_load,
        "contact_edges": found.contact_edges,
        "stick_edges": found.stick_edges,
        "contact_half_width": np.diff(found.contact_edges, axis=1)[:, 0] / 2,
        "stick_half_width": np.diff(found.stick_edges, axis=1)[:, 0] / 2,
        "tangential_displacement": nothing,
        "normal_approach": nothing,
    }
    return {name: freeze(values) for name, values in series.items()}  # type: ignore[arg-type]


def _settings(result: SurfaceResult, mapping: Mapping, *, stated: bool) -> dict[str, object]:
    known = {"element_size": mapping.element_size} if mapping.element_size else {}
    derived = ["state", "contact_edges", "stick_edges", *([] if stated else ["normal_load", "tangential_load"])]
    return {"source": result.source, DERIVED: derived, **known}


def _last_cycle(scene: Scene, history: History) -> NDArray[np.intp]:
    """Indices of the last whole cycle (of a path that is not periodic: all, if they go from its start to its end); or none."""
    path, time = scene.load.path(), history.time
    if path.period is None:
        tolerance = 1e-6 * (path.initial_loading[-1].end - path.start)
        whole = time[0] <= path.start + tolerance and time[-1] >= path.initial_loading[-1].end - tolerance
        return np.arange(len(time) if whole else 0)
    tolerance = 1e-9 * path.period
    end = path.cycle_start + np.floor((time[-1] - path.cycle_start + tolerance) / path.period) * path.period
    inside = np.flatnonzero((time >= end - path.period - tolerance) & (time <= end + tolerance))
    if not len(inside) or time[inside[0]] > end - path.period + tolerance or time[inside[-1]] < end - tolerance:
        return np.arange(0)
    return inside


def _dissipation(result: SurfaceResult, steps: NDArray[np.intp]) -> tuple[Array, tuple[str, ...]]:
    """w(x) of the last cycle, (n_points,), NaN where it can't be had; and how it came about."""
    if result.slip is None or len(steps) < FEWEST:
        return np.full(len(result.x), np.nan), ()
    words = f"its dissipation is the sum of q ds of its own shear and slip over the {len(steps)} instants of a cycle"
    return friction_work(result.shear[steps], result.slip[steps]), (words,)


def friction_work(shear: Array, slip: Array) -> Array:
    """Sum of q ds over the instants by the trapezoidal rule: (k, n), (k, n) -> (n,).

    >>> friction_work(np.array([[0.0], [2.0]]), np.array([[0.0], [3.0]])).tolist()
    [3.0]
    """
    return np.asarray(np.sum((shear[1:] + shear[:-1]) / 2 * np.diff(slip, axis=0), axis=0))


def _skipped(result: SurfaceResult, history: History, steps: NDArray[np.intp], density: Array) -> dict[str, tuple[int, str]]:
    count = len(history.time)
    lacking = dict.fromkeys(("tangential_displacement", "normal_approach", "loop_work"), (count, LACKING))
    if result.slip is None:
        lacking["slip"] = (count, LACKING)
    if not len(steps):
        lacking[WHOLE_CYCLE] = (count, f"{LACKING}, which goes from time {history.time[0]:.6g} to {history.time[-1]:.6g}")
    if np.isnan(density).any():
        few = f", for a cycle of {len(steps)} instants is too coarse to work it out (less than {FEWEST})"
        whole = "; it takes a whole cycle, or a whole path from the unloaded start"
        why = "; it takes slip" if result.slip is None else whole if not len(steps) else few
        lacking |= dict.fromkeys(("dissipation", "dissipation_density"), (count, LACKING + why))
    return lacking


def permanent_stick(edges: Array) -> float:
    """Half-width that sticks at every instant, of stick edges (k, 2) [length]; NaN where nothing does, or there is no instant."""
    if not len(edges) or np.isnan(edges).any():
        return float("nan")
    half = float(edges[:, 1].min() - edges[:, 0].max()) / 2
    return half if half > 0 else float("nan")


def of_own_file(solution: ContactSolution, source: str, scene: Scene) -> ContactSolution:
    """A solution of the project's own, scored as it is; InputError where it answers another scene."""
    for part in ("material", "profile", "friction", "load"):
        own, asked = getattr(solution.scene, part), getattr(scene, part)
        if own != asked:
            raise InputError(f"{source}: it answers another scene: {part} is {own!r} there and {asked!r} in {scene.name}")
    return solution
