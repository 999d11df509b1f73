"""Finite elements under a prescribed displacement: the loads at which their own U is what the rig
prescribes.

The engine takes loads. Its U at loads Q_k is found by a run, and the loads are corrected until U +
Q/k_s is U_act at every row. What lacks is given to corrected half-plane theory, whose tangent is
that of the finite elements to a per cent or two::

    r_k = U_FE(Q_k) + Q_k/k_s - U_act,     c_k = c_(k-1) + r_k,     Q_(k+1) = Q_theory(U_act - c_k)

with the memory of friction on the whole path. Each run leaves about a hundredth of the residual.
The approach of the actuator is met in the same way, by P. The answer at the end is that of the
finite elements, whatever theory says of it.

Gross sliding. At |Q| = f P a slide of the upper body as a whole changes no force: it is added to
slip and U after the run, and its work f P |slide| to the dissipation. How far it goes is what the
elements' own U leaves of U_act. The engine has no answer at |Q| = f P itself, where nothing sticks:
it takes the limit but for a share of 1e-9.

Between two rows Q is straight in time. Where P varies this takes a share of W; theory on these rows
and on rows four times as close measures it, and it counts as uncertain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

import halfplane_fe
from halfplane_fe import FiniteElementSolution, SolverSettings
from halfplane_fe.run import Progress
from meshes import MeshSettings
from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    BodyEffects,
    ConvergenceError,
    Estimate,
    InputError,
    PolygonLoad,
    Rig,
    Scene,
    freeze,
)
from scenes.array_types import Array
from semi_analytic.answer_of_rig import (
    Rigged,
    notes_of_slides,
    rigged,
    slides_of,
    steady_cycle,
)
from semi_analytic.corrected import checked_effects
from semi_analytic.corrected_memory import area_of_loop
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
# Share of f P that the engine keeps below the limit of friction.
_BELOW_LIMIT = 1e-9
# Largest residual over the range of U. A run leaves about a hundredth of it.
_TOLERANCE = 1e-9
# Residual from which on the mesh stays. Another mesh moves U by 2e-7 of its range.
_SAME_SCALES = 1e-5
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
        (k,) largest |U + Q/k_s - U_act| over the range of U_act after each run, or the same of the
        approach
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
        Where the bodies part; where the displacement of these bodies has no theory to start from.
    ConvergenceError
        Where the loads are not found, or a run does not converge.
    """
    settings = settings or SolverSettings()
    rig = rigged(scene, _start_of_theory(scene))
    finer: ActuatorRows | None = None
    if rows is None:
        rows, steady_from = _rows(rig, settings)
        finer = _finer_rows(rig, rows)
    else:
        steady_from = len(rows.ends) - 2 if len(rows.ends) > 1 else None
    elements = replace(settings, steps_per_cycle=_INCREMENTS)
    missing = _Missing.nothing(rows)
    residuals: list[float] = []
    scales = None
    for _ in range(_MOST_RUNS):
        driven = rig.follow_rows(missing.taken_off(rows))
        of_loads = scene_of_loads(scene, driven, steady_from)
        solution = halfplane_fe.solve(of_loads, mesh, elements, progress, scales=scales)
        residual = _residual(rig, rows, driven, solution)
        drift = 0.0
        if steady_from is not None:
            # The cycle ends under the loads that it began with.
            drift = abs(float(residual.displacement[-1]))
            residual = residual.without_end()
        residuals.append(residual.largest(rows))
        # Scales of other loads would make W uncertain by what the loads differ, and new ones make
        # another mesh.
        scales = solution.scales if residuals[-1] <= _SAME_SCALES else None
        if residuals[-1] <= _TOLERANCE:
            share = 0.0
            if finer is not None:
                of_finer = rig.follow_rows(missing.taken_off(finer))
                share = _share_of_rows(driven, of_finer, steady_from)
            slid = _with_slides(solution, driven)
            noted = _with_notes(slid, scene, driven, steady_from, residuals, share)
            return RigRun(_with_drift(noted, drift), tuple(residuals))
        missing = missing.plus(residual)
        if len(residuals) == 1:
            rig, missing = _with_compliances(rig, rows, driven, missing)
    raise ConvergenceError(
        f"the loads at which the finite elements move as prescribed were not found in {_MOST_RUNS}"
        f" runs: the last one leaves {residuals[-1]:.2g} of the range of U",
        solution,
    )


def _start_of_theory(scene: Scene) -> BodyEffects | None:
    """What the bodies add to half-planes. Of curved faces it is not known: half-planes whose datum
    is as far as their bodies are deep are near enough to start from.
    """
    if scene.bodies.half_planes:
        return None
    if not scene.bodies.faces_are_true:
        return checked_effects(halfplane_fe.body_effects(scene))
    depths = [body.least_depth for body in (scene.bodies.lower, scene.bodies.upper)]
    lengths = [min(depth, scene.profile.datum_length) for depth in depths]
    return BodyEffects(datum_length=math.sqrt(lengths[0] * lengths[1]))


class _Missing(NamedTuple):
    """What theory lacks of the finite elements' approach and U at some instants, (n,) each."""

    time: Array
    approach: Array
    displacement: Array

    @classmethod
    def nothing(cls, rows: ActuatorRows) -> _Missing:
        """Theory as it is."""
        return cls(rows.time, np.zeros(len(rows.time)), np.zeros(len(rows.time)))

    def plus(self, residual: _Missing) -> _Missing:
        """With what a run has left."""
        return self._replace(
            approach=self.approach + residual.approach,
            displacement=self.displacement + residual.displacement,
        )

    def without_end(self) -> _Missing:
        """Nothing at the last instant."""
        inside = np.append(np.ones(len(self.time) - 1), 0.0)
        return self._replace(
            approach=inside * self.approach, displacement=inside * self.displacement
        )

    def taken_off(self, rows: ActuatorRows) -> ActuatorRows:
        """What is left to theory at rows, which may be others."""
        return rows._replace(
            normal=rows.normal - np.interp(rows.time, self.time, self.approach),
            displacement=rows.displacement - np.interp(rows.time, self.time, self.displacement),
        )

    def largest(self, rows: ActuatorRows) -> float:
        """The largest of it over the range of what the rows prescribe."""
        of_displacement = np.max(np.abs(self.displacement)) / (np.ptp(rows.displacement) or 1.0)
        of_approach = np.max(np.abs(self.approach)) / (np.ptp(rows.normal) or 1.0)
        return float(max(of_displacement, of_approach))


def _with_compliances(
    rig: Rigged, rows: ActuatorRows, driven: Driven, missing: _Missing
) -> tuple[Rigged, _Missing]:
    """Theory with what it lacks in proportion to P and Q added to its compliances, and the rest.

    Of curved faces theory starts without them: its tangent would be wrong by a factor.
    """
    number = np.searchsorted(driven.time, rows.time)

    def proportion(values: Array, loads: Array) -> float:
        """The compliance that fits by least squares."""
        square = float(loads @ loads)
        return float(values @ loads) / square if square > 0 else 0.0

    load = driven.followed.normal_load[number]
    force = driven.followed.tangential_load[number]
    normal = proportion(missing.approach, load)
    tangential = proportion(missing.displacement, force)
    effects = replace(
        rig.effects,
        normal_compliance=Estimate(rig.effects.normal_compliance.value + normal),
        tangential_compliance=Estimate(rig.effects.tangential_compliance.value + tangential),
    )
    rest = missing._replace(
        approach=missing.approach - normal * load,
        displacement=missing.displacement - tangential * force,
    )
    return rigged(rig.scene, effects), rest


def _residual(
    rig: Rigged, rows: ActuatorRows, driven: Driven, solution: FiniteElementSolution
) -> _Missing:
    """How far the actuators of the finite elements are beyond what is prescribed at the rows."""
    number = np.searchsorted(driven.time, rows.time)
    load = driven.followed.normal_load[number]
    force = driven.followed.tangential_load[number]
    compliance = rig.compliance
    to_datum = _beyond_datum(rig)
    moved = _at_rows(solution, rows.time, solution.tangential_displacement)
    displacement = moved + (to_datum + compliance.tangential_spring) * force
    displacement = displacement + driven.free[number] - rows.displacement
    displacement[0] = 0.0
    approach = np.zeros(len(rows.time))
    if rig.scene.load.states_approach:
        pressed = _at_rows(solution, rows.time, solution.normal_approach)
        approach = pressed + (to_datum + compliance.normal_spring) * load - rows.normal
        approach[0] = 0.0
    return _Missing(rows.time, approach, displacement)


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

    work = driven.work(_last_cycle(driven, steady_from))
    work_of_finer = finer.work(_last_cycle(finer, steady_from))
    return abs(work / work_of_finer - 1) if work_of_finer > 0 else 0.0


def _with_drift(solution: FiniteElementSolution, drift: float) -> FiniteElementSolution:
    """The solution with what U lacks at the end of its cycle [length], where it is not yet steady,
    in the uncertainty of W, and a note of it.
    """
    moved = float(np.ptp(solution.tangential_displacement[solution.last_cycle]))
    if drift <= _TOLERANCE * moved:
        return solution
    largest = float(np.max(np.abs(solution.tangential_load[solution.last_cycle])))
    note = f"rig: the cycle ends {drift / moved:.1g} of the range of U from where it began"
    record = replace(solution.record, notes=(*solution.record.notes, note))
    uncertainty = solution.dissipation_uncertainty + largest * drift
    return replace(solution, record=record, dissipation_uncertainty=uncertainty)


def _last_cycle(driven: Driven, steady_from: int | None) -> slice:
    """Instants of the steady cycle, both its ends; of the path where there is none."""
    if steady_from is None:
        return slice(0, None)
    return slice(driven.ends[steady_from], driven.ends[steady_from + 1] + 1)


def scene_of_loads(scene: Scene, driven: Driven, steady_from: int | None) -> Scene:
    """The scene with P and Q in the place of the displacement, Q just below the limit of friction
    where the bodies slide; what is before the last cycle is initial loading.
    """
    load = driven.followed.normal_load
    limit = scene.friction.coefficient * load * (1 - _BELOW_LIMIT)
    force = np.clip(driven.followed.tangential_load, -limit, limit)
    points = list(zip(load.tolist(), force.tolist(), strict=True))
    loading = tuple(points[1:])
    cycle: tuple[tuple[float, float], ...] = ()
    if steady_from is not None:
        begin = driven.ends[steady_from]
        end = driven.ends[steady_from + 1]
        loading = tuple(points[1 : begin + 1])
        cycle = tuple(points[begin + 1 : end])
    times = tuple(driven.time.tolist())
    polygon = PolygonLoad(initial_loading=loading, cycle=cycle, times=times)
    return scene.vary(load=polygon, rig=Rig(), cycles=1)


def _with_slides(solution: FiniteElementSolution, driven: Driven) -> FiniteElementSolution:
    """The solution with what slides as a whole: in U, slip and the states of points, and in the
    dissipation of the last cycle, or of the path.

    A slide begins and ends where the elements' U says so: its way is uncertain by twice the
    uncertainty of U.
    """
    slides = slides_of(driven, slice(0, None))
    if not slides:
        return solution
    free = np.interp(solution.time, driven.time, driven.free)
    displacement = solution.tangential_displacement + free
    slip = solution.slip + free[:, None]
    # A step slides where it lies within a slide; an instant, where one of its steps does.
    begins = solution.time[:-1]
    ends = solution.time[1:]
    allowed = _SAME * float(np.ptp(solution.time))
    sense = np.zeros(len(begins))
    for part in slides:
        within = (begins >= part.begin - allowed) & (ends <= part.end + allowed)
        sense[within] = np.sign(part.way)
    sense_at = np.append(sense, 0.0)
    sense_at[1:] = np.where(sense_at[1:] != 0, sense_at[1:], sense)
    slipping = np.where(sense_at > 0, SLIP_FORWARD, SLIP_REVERSE)[:, None]
    is_sliding = (sense_at != 0)[:, None] & (solution.state != OPEN)
    state = np.where(is_sliding, slipping, solution.state)
    # The share that Q was kept below the limit hangs on one node.
    friction = solution.scene.friction.coefficient
    at_limit = np.sign(sense_at)[:, None] * friction * solution.pressure
    shear = np.where(is_sliding, at_limit, solution.shear)
    stick_edges = np.where((sense_at != 0)[:, None], np.nan, solution.stick_edges)

    in_cycle = np.zeros(len(begins), dtype=bool)
    in_cycle[solution.last_cycle[:-1]] = True
    ways = np.abs(np.diff(free)) * (in_cycle & (sense != 0))
    pressure = (solution.pressure[1:] + solution.pressure[:-1]) / 2
    density = friction * (ways @ pressure)
    work = float(density @ solution.weights)
    loop = area_of_loop(solution.tangential_load[solution.last_cycle], free[solution.last_cycle])
    in_time = solution.time[solution.last_cycle]
    of_movement = 2 * solution.uncertainties["tangential_displacement"]
    uncertainty = solution.dissipation_uncertainty
    uncertainties = dict(solution.uncertainties)
    for part in slides:
        if part.end > in_time[0] + allowed:
            uncertainty += part.work / abs(part.way) * of_movement
            of_density = friction * float(np.max(solution.pressure)) * of_movement
            uncertainties["largest_dissipation_density"] += of_density
            uncertainties["largest_slip"] += of_movement
    permanent = solution.permanent_stick_half_width
    if np.any(ways):
        permanent = math.nan
    works = solution.cycle_dissipation.copy()
    works[-1] += work
    return replace(
        solution,
        tangential_displacement=freeze(displacement, float),
        shear=freeze(shear, float),
        slip=freeze(slip, float),
        state=freeze(state, np.int8),
        stick_edges=freeze(stick_edges, float),
        stick_half_width=freeze(np.diff(stick_edges)[:, 0] / 2, float),
        dissipation_density=freeze(solution.dissipation_density + density, float),
        dissipation=solution.dissipation + work,
        dissipation_uncertainty=uncertainty,
        uncertainties=uncertainties,
        cycle_dissipation=freeze(works, float),
        loop_work=solution.loop_work + loop,
        permanent_stick_half_width=permanent,
    )


def _at_rows(solution: FiniteElementSolution, time: Array, values: Array) -> Array:
    """Values at the rows: ends of increments."""
    number = np.clip(np.searchsorted(solution.time, time), 1, len(solution.time) - 1)
    is_before = time - solution.time[number - 1] < solution.time[number] - time
    number = number - is_before
    apart = np.abs(solution.time[number] - time)
    assert np.all(apart <= 1e-9 * np.ptp(time)), "a row is no end of an increment"
    return values[number]


def _beyond_datum(rig: Rigged) -> float:
    """(A/pi) ln(L/L0) of half-planes: L is where the rig prescribes, L0 where the solution counts
    from [1 / stress]; 0 of bodies.
    """
    if not rig.scene.bodies.half_planes:
        return 0.0
    ratio = rig.compliance.datum_length / rig.scene.profile.datum_length
    return float(rig.compliance.unit * np.log(ratio))


def _with_notes(
    solution: FiniteElementSolution,
    scene: Scene,
    driven: Driven,
    steady_from: int | None,
    residuals: list[float],
    share: float,
) -> FiniteElementSolution:
    """The solution with notes on how its loads were found and what slides, and what Q between rows
    costs W, a share of it, in its uncertainty.
    """
    _, length, _ = scene.unit_words
    loads = "P and Q follow" if scene.load.states_approach else "Q follows"
    note = (
        f"rig: {loads} from the displacement, in {len(residuals)} runs; U is what the rig"
        f" prescribes to {residuals[-1]:.1g} of its range at every row, and Q is straight between"
        f" rows, which makes W uncertain by {share:.2g} of itself; U is that of the contact, in"
        f" {length}"
    )
    slides = notes_of_slides(scene, driven, _last_cycle(driven, steady_from))
    record = replace(solution.record, notes=(*solution.record.notes, note, *slides))
    uncertainty = solution.dissipation_uncertainty + share * solution.dissipation
    return replace(solution, record=record, dissipation_uncertainty=uncertainty)
