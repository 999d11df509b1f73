"""Finite elements under a prescribed displacement: the loads at which their own U is what the rig
prescribes.

The engine takes loads. Its U at loads Q_k is found by a run, and the loads are corrected until U +
Q/k_s is U_act at every row. What lacks is given to corrected half-plane theory, whose tangent is
that of the finite elements to a per cent or two::

    r_k = U_FE(Q_k) + Q_k/k_s - U_act,     c_k = c_(k-1) + r_k,     Q_(k+1) = Q_theory(U_act - c_k)

with the memory of friction on the whole path. Each run leaves about a hundredth of the residual.
The answer at the end is that of the finite elements, whatever theory says of it. Between two rows Q
is straight in time. Where P varies this takes a share of W; theory on these rows and on rows four
times as close measures it, and it counts as uncertain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

import halfplane_fe
from halfplane_fe import FiniteElementSolution, SolverSettings
from halfplane_fe.run import Progress
from meshes import MeshSettings
from scenes import (
    BodyEffects,
    ConvergenceError,
    InputError,
    PolygonLoad,
    Rig,
    Scene,
)
from scenes.array_types import Array
from semi_analytic.answer_of_rig import Rigged, rigged, slides_of, steady_cycle
from semi_analytic.corrected import checked_effects
from semi_analytic.driven import ActuatorRows, Driven, actuator_rows

# Rows of a cycle for each increment of the settings: Q is straight between them. Two left 6e-3 of W
# at P = 90 ± 30 N/mm, eight leave 3e-4; where P rests the form of Q over time counts for nothing.
_ROWS = 8
_ROWS_AT_REST = 2
# Share of P within which it rests.
_SAME = 1e-12
# Rows of the measurement of that for each row.
_FINER = 4
# Increments between two rows: as few as the settings take.
_INCREMENTS = 4
# Largest residual over the range of U. A run leaves about a hundredth of it.
_TOLERANCE = 1e-9
# Runs at most: five or six are made.
_MOST_RUNS = 15


@dataclass(frozen=True, eq=False)
class RigRun:
    """The finite elements' answer, and how it was found.

    Attributes
    ----------
    solution
        under the loads that were found, which its scene states
    residuals
        (k,) largest |U + Q/k_s - U_act| over the range of U_act after each run
    """

    solution: FiniteElementSolution
    residuals: tuple[float, ...]


def solve_rig(
    scene: Scene,
    mesh: MeshSettings | None = None,
    settings: SolverSettings | None = None,
    progress: Progress | None = None,
    rows: ActuatorRows | None = None,
) -> RigRun:
    """Solve a scene with a prescribed tangential displacement by finite elements.

    Parameters
    ----------
    mesh, settings, progress
        as of `halfplane_fe.solve`; `steps_per_cycle` sets the rows at which U is prescribed
    rows
        of the actuators, in place of those of the scene's path

    Raises
    ------
    InputError
        For a prescribed approach; where the bodies slide as a whole or part; where the displacement
        of these bodies has no theory to start from.
    ConvergenceError
        Where the loads are not found, or a run does not converge.
    """
    load = scene.load
    settings = settings or SolverSettings()
    if load.states_approach:
        raise InputError(
            "load.approach: finite elements take a prescribed tangential displacement beside loads"
            " P; state P, or take `halfplane exact`"
        )
    effects: BodyEffects | None = None
    if not scene.bodies.half_planes:
        effects = halfplane_fe.body_effects(scene)
    rig = rigged(scene, checked_effects(effects))
    finer: ActuatorRows | None = None
    if rows is None:
        rows, steady_from = _rows(rig, settings)
        finer = _finer_rows(rig, rows)
    else:
        steady_from = len(rows.ends) - 2 if len(rows.ends) > 1 else None
    elements = replace(settings, steps_per_cycle=_INCREMENTS)
    to_datum = _beyond_datum(rig)
    correction = np.zeros(len(rows.time))
    travel = float(np.ptp(rows.displacement)) or 1.0
    residuals: list[float] = []
    scales = None
    for _ in range(_MOST_RUNS):
        driven = rig.follow_rows(rows._replace(displacement=rows.displacement - correction))
        _require_stick(driven, rows, scene)
        of_loads = scene_of_loads(scene, driven, rows, steady_from)
        solution = halfplane_fe.solve(of_loads, mesh, elements, progress, scales=scales)
        scales = solution.scales
        force = driven.followed.tangential_load
        moved = _at_rows(solution, rows.time) + to_datum * force
        residual = moved + rig.compliance.tangential_spring * force - rows.displacement
        residual[0] = 0.0
        residuals.append(float(np.max(np.abs(residual))) / travel)
        if residuals[-1] <= _TOLERANCE:
            share = 0.0
            if finer is not None:
                moved_at_finer = np.interp(finer.time, rows.time, correction)
                of_finer = finer._replace(displacement=finer.displacement - moved_at_finer)
                share = _share_of_rows(driven, rig.follow_rows(of_finer), steady_from)
            return RigRun(_with_notes(solution, rig, residuals, share), tuple(residuals))
        correction = correction + residual
    raise ConvergenceError(
        f"the loads at which the finite elements move as prescribed were not found in {_MOST_RUNS}"
        f" runs: the last one leaves {residuals[-1]:.2g} of the range of U",
        solution,
    )


def _rows(rig: Rigged, settings: SolverSettings) -> tuple[ActuatorRows, int | None]:
    """Rows of the initial loading and of the cycles up to the first steady one of theory, and its
    index.
    """
    scene = rig.scene
    path = scene.load.path_of_actuators()
    steps = _ROWS * settings.steps_per_cycle
    if path.period is None:
        return actuator_rows(path, 0, steps=steps), None
    first = actuator_rows(path, 1, steps=steps)
    in_cycle = first.normal[first.ends[0] :]
    if np.ptp(in_cycle) <= _SAME * np.max(in_cycle):
        steps = _ROWS_AT_REST * settings.steps_per_cycle
    for cycles in range(2, max(scene.cycles, 2) + 1):
        rows = actuator_rows(path, cycles, steps=steps)
        steady_from = steady_cycle(rig.follow_rows(rows))
        if steady_from is not None:
            break
    else:
        raise InputError(
            f"cycles: by theory no cycle among the first {cycles} is steady; raise cycles"
        )
    last = rows.ends[steady_from + 1]
    kept = rows._replace(
        time=rows.time[: last + 1],
        normal=rows.normal[: last + 1],
        displacement=rows.displacement[: last + 1],
        ends=rows.ends[: steady_from + 2],
    )
    return kept, steady_from


def _finer_rows(rig: Rigged, rows: ActuatorRows) -> ActuatorRows:
    """The rows with others between them, and the path's displacement and P there."""
    share = np.arange(_FINER) / _FINER
    between = rows.time[:-1, None] + np.diff(rows.time)[:, None] * share
    time = np.append(between.ravel(), rows.time[-1])
    normal, displacement = rig.scene.load.path_of_actuators().at(time)
    ends = tuple(_FINER * end for end in rows.ends)
    return ActuatorRows(time, np.maximum(normal, 0.0), displacement, ends)


def _share_of_rows(driven: Driven, finer: Driven, steady_from: int | None) -> float:
    """Difference of W by theory on rows and on finer rows, over W."""

    def work(of: Driven) -> float:
        if steady_from is None:
            return of.work(slice(0, None))
        return of.work(slice(of.ends[steady_from], of.ends[steady_from + 1] + 1))

    work_of_finer = work(finer)
    return abs(work(driven) / work_of_finer - 1) if work_of_finer > 0 else 0.0


def _require_stick(driven: Driven, rows: ActuatorRows, scene: Scene) -> None:
    """InputError where the bodies slide as a whole."""
    slides = slides_of(driven, slice(0, None))
    if not slides and len(driven.time) == len(rows.time):
        return
    begin = slides[0].begin if slides else float(driven.time[-1])
    raise InputError(
        f"load.tangential_displacement: from time {begin:.6g} on the bodies slide as a whole, which"
        " finite elements do not take; make the displacement less, or take `halfplane exact"
        f" {scene.name}`, which does"
    )


def scene_of_loads(
    scene: Scene, driven: Driven, rows: ActuatorRows, steady_from: int | None
) -> Scene:
    """The scene with P and Q at the rows in the place of the displacement; what is before the last
    cycle is initial loading.
    """
    forces = driven.followed.tangential_load
    points = list(zip(rows.normal.tolist(), forces.tolist(), strict=True))
    loading = tuple(points[1:])
    cycle: tuple[tuple[float, float], ...] = ()
    if steady_from is not None:
        begin = rows.ends[steady_from]
        loading = tuple(points[1 : begin + 1])
        cycle = tuple(points[begin + 1 : -1])
    load = PolygonLoad(initial_loading=loading, cycle=cycle, times=tuple(rows.time.tolist()))
    return scene.vary(load=load, rig=Rig(), cycles=1)


def _at_rows(solution: FiniteElementSolution, time: Array) -> Array:
    """U at the rows: ends of increments."""
    number = np.clip(np.searchsorted(solution.time, time), 1, len(solution.time) - 1)
    is_before = time - solution.time[number - 1] < solution.time[number] - time
    number = number - is_before
    apart = np.abs(solution.time[number] - time)
    assert np.all(apart <= 1e-9 * np.ptp(time)), "a row is no end of an increment"
    return solution.tangential_displacement[number]


def _beyond_datum(rig: Rigged) -> float:
    """(A/pi) ln(L/L0) of half-planes: L is where the rig prescribes, L0 where the solution counts
    from [1 / stress]; 0 of bodies.
    """
    if not rig.scene.bodies.half_planes:
        return 0.0
    ratio = rig.compliance.datum_length / rig.scene.profile.datum_length
    return float(rig.compliance.unit * np.log(ratio))


def _with_notes(
    solution: FiniteElementSolution, rig: Rigged, residuals: list[float], share: float
) -> FiniteElementSolution:
    """The solution with a note on how its loads were found, and what Q between rows costs W, a
    share of it, in its uncertainty.
    """
    _, length, _ = rig.scene.unit_words
    note = (
        f"rig: Q follows from the displacement, in {len(residuals)} runs; U is what the rig"
        f" prescribes to {residuals[-1]:.1g} of its range at every row, and Q is straight between"
        f" rows, which makes W uncertain by {share:.2g} of itself; U is that of the contact, in"
        f" {length}"
    )
    record = replace(solution.record, notes=(*solution.record.notes, note))
    uncertainty = solution.dissipation_uncertainty + share * solution.dissipation
    return replace(solution, record=record, dissipation_uncertainty=uncertainty)
