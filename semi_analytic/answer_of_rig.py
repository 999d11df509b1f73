"""The answer to a scene whose rig prescribes displacements, by corrected theory, as `Findings`: the
loads of `driven`, and the fields of `corrected` under them.

The answer's scene states the loads that were found, in the place of the displacements: a polygon
with a point for each instant. Cycles before the steady one are part of its initial loading.

Every value is taken from steps half as long as those that its error is stated by. At constant P W
does not depend on the steps.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from scenes import BodyEffects, Hertz, InputError, PolygonLoad, Rig, Scene
from scenes.array_types import Array
from scenes.errors import first_line
from semi_analytic.answer import Findings, Question, mirrored_points, neglected_coupling
from semi_analytic.answer_by_memory import folded
from semi_analytic.corrected import (
    OF_RIG,
    OddPart,
    PathRows,
    PathSeries,
    PointFields,
    certificates_of,
    curvatures_of,
    grids_at,
    instants_of,
    notes_of_effects,
    odd_part_on_grids,
    permanent_stick,
    series_at,
    table_of,
    work_uncertainty_by_bodies,
)
from semi_analytic.corrected_memory import Curvatures, PunchTable, follow
from semi_analytic.driven import (
    ActuatorRows,
    Compliance,
    Driven,
    actuator_rows,
    follow_actuator,
    loads_of_approach,
)
from semi_analytic.elasticity import composite_modulus
from semi_analytic.next_order import (
    has_next_order,
    ratio_of_next_order,
    uncertain_fraction_of_tilt_and_strain,
    without_next_order,
)
from semi_analytic.odd_memory import ODD_NUMBERS, Declined
from semi_analytic.odd_part_of_rig import loads_of_cycle, odd_part_of_rig
from semi_analytic.profiles import SymmetricContact, contact_of

# Share of f P by which the memory curves of two cycles may differ and be the same state.
_STEADY = 1e-9
_PLACES = 200
# Rows on the two steps around the end of a slide, and ends that have them.
_ROWS_AT_END = 33
_MOST_ENDS = 200
# Slides of this share of the way of the actuator are round-off.
_NO_SLIDE = 1e-9
# Straight steps of a cycle on grids, which take few.
_STEPS_ON_GRIDS = 55
# Of a path that `odd_part_of_rig` states again: the second cycle is steady, if not the first.
_STEADY_CYCLE = 1
# Slides that a note names one by one.
_MOST_NAMED = 4


# ------------------------------------------------------------------------------------ the movements
@dataclass(frozen=True, eq=False)
class Rigged:
    """A scene with prescribed displacements, ready to be followed.

    Attributes
    ----------
    scene
        as asked
    contact, modulus, effects
        normal contact of half-planes, E*, what the bodies add
    compliance
        of contact and rig
    """

    scene: Scene
    contact: SymmetricContact
    modulus: float
    effects: BodyEffects
    compliance: Compliance

    def follow(self, cycles: int, refinement: int, extra_times: Array | None = None) -> Driven:
        """The path by steps, `refinement` times as many as at least, also at `extra_times` (k,)."""
        path = self.scene.load.path_of_actuators()
        return self.follow_rows(actuator_rows(path, cycles, refinement, extra_times))

    def follow_rows(self, rows: ActuatorRows) -> Driven:
        """The path by given steps."""
        scene = self.scene
        if scene.load.states_approach:
            loads = loads_of_approach(
                self.contact, self.modulus, self.compliance, rows.load_or_approach
            )
            rows = rows._replace(load_or_approach=loads)
        table = self._table(rows)
        largest_load = float(np.max(rows.load_or_approach))
        self.compliance.require_unique(float(table.half_width(table.largest_s)), largest_load)
        return follow_actuator(table, scene.friction.coefficient, self.compliance, rows)

    def _table(self, rows: ActuatorRows) -> PunchTable:
        """Flat punches up to the largest contact, whatever Q is."""
        if not np.any(rows.load_or_approach > 0):
            raise InputError(
                "load: P is never positive, so that the bodies never touch; it is a compression"
            )
        curvatures = self.compliance.curvatures
        limit = self.scene.friction.coefficient * rows.load_or_approach
        widening_force = -np.sign(curvatures.normal_under_shear) * limit
        loads = PathRows(rows.time, rows.load_or_approach, widening_force, rows.ends, None)
        return table_of(self.contact, self.modulus, loads, curvatures)


def rigged(scene: Scene, effects: BodyEffects | None) -> Rigged:
    """Prepare a scene with prescribed displacements: its normal contact, and the compliance of
    contact, bodies and springs of the rig.

    Half-planes without `effects` get those of the rig's datum length alone.

    Raises
    ------
    InputError
        For finite bodies without their effects.
    """
    rig = scene.rig
    if effects is None:
        if not scene.bodies.half_planes:
            raise InputError(
                "load.tangential_displacement: the displacement of these bodies is not that of"
                " half-planes; give effects = halfplane_fe.body_effects(scene)"
            )
        assert rig.datum_length is not None  # for the type checker: the scene was checked
        effects = BodyEffects(datum_length=rig.datum_length)
    modulus = composite_modulus(scene.material)
    compliance = Compliance(
        unit_compliance=2 / (math.pi * modulus),
        datum_length=effects.datum_length,
        normal=effects.normal_compliance.value,
        tangential=effects.tangential_compliance.value,
        normal_spring=1 / (rig.normal_stiffness or math.inf),
        tangential_spring=1 / (rig.tangential_stiffness or math.inf),
        curvatures=curvatures_of(effects),
        tilts=_tilts_of(scene, effects),
    )
    contact = contact_of(scene.profile, scene.material)
    return Rigged(scene, contact, modulus, effects, compliance)


def _tilts_of(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
    """R alpha_P alpha_Q and R alpha_Q^2 [1 / (stress load)]; 0 where the profile is no parabola, of
    which alone the moment under a tilt is known.
    """
    if not isinstance(scene.profile, Hertz):
        return 0.0, 0.0
    under_shear = effects.tilt_under_shear.value
    under_pressure = effects.tilt_under_pressure.value
    radius = scene.profile.radius
    return radius * under_pressure * under_shear, radius * under_shear**2


class _Slide(NamedTuple):
    """One stretch of gross sliding."""

    begin: float  # time
    end: float
    distance: float  # signed, of the upper body over the lower along +x [length]
    work: float  # f P times the way [energy / thickness]


def slides_of(driven: Driven, rows: slice) -> list[_Slide]:
    """Spans of time in which the bodies slide as a whole, in some rows of a path driven by an
    actuator: begin, end, distance and friction work of each.

    Neighbouring rows that slide in one direction make one span. The first of the `rows` ends the
    step before them. A slide below a tiny share of the actuator's range is none.
    """
    row_numbers = np.arange(len(driven.time))[rows]
    actuator_range = float(np.ptp(driven.actuator)) or 1.0
    direction = np.sign(driven.slide)
    direction[np.abs(driven.slide) <= _NO_SLIDE * actuator_range] = 0
    slides: list[_Slide] = []
    for row_before, row in pairwise(row_numbers.tolist()):
        if not direction[row]:
            continue
        slide_in_step = _Slide(
            float(driven.time[row_before]),
            float(driven.time[row]),
            float(driven.slide[row]),
            float(driven.slide_work[row]),
        )
        if (
            slides
            and slides[-1].end == slide_in_step.begin
            and slides[-1].distance * slide_in_step.distance > 0
        ):
            slide_before = slides[-1]
            slides[-1] = _Slide(
                slide_before.begin,
                slide_in_step.end,
                slide_before.distance + slide_in_step.distance,
                slide_before.work + slide_in_step.work,
            )
        else:
            slides.append(slide_in_step)
    return slides


# --------------------------------------------------------------------------------- the whole answer
def of_rig(question: Question) -> Findings:
    """The answer to a scene whose rig prescribes displacements: loads, fields, friction work and
    their errors.

    The loads are found step by step, by steps and by steps twice as long; the difference is stated
    as error. Fields are those of half-plane theory, corrected for finite bodies, under these loads.

    Raises
    ------
    InputError
        For `straight_steps`, for materials, profiles or rigs that corrected theory does not take,
        and for springs that leave more than one answer.
    """
    started = clock.perf_counter()
    if question.straight_steps:
        raise InputError(
            "straight_steps: it goes with given loads; leave it out where a displacement is"
            " prescribed"
        )
    rig = rigged(question.scene, question.effects)
    fine_path, coarse_path, steady_from = _followed(rig, question.time)
    last_cycle, rows_of_answer = _rows_of(fine_path, question.scene, steady_from)
    bodies = _series(rig, fine_path)
    history_done = clock.perf_counter()

    x = question.x
    if x is None:
        x = mirrored_points(1.05 * float(np.max(bodies.half_width)))
    distance, number_of_distance = folded(x)
    time, row_numbers = instants_of(question, rows_of_answer, last_cycle)
    points = PointFields(bodies, distance)
    fields = grids_at(question, points, distance, row_numbers)
    cycle_energy = _energy_of(rig, fine_path, coarse_path, bodies, steady_from)
    errors = cycle_energy.errors
    density = np.full(len(distance), np.nan)
    if question.wants("dissipation_density"):
        density = points.work(last_cycle)
    wants_work = question.wants("dissipation")
    series_of_instants = series_at(question, bodies, row_numbers)
    compliance_to_datum = _to_datum_of_answers(rig)
    for displacement, load in (
        ("tangential_displacement", "tangential_load"),
        ("normal_approach", "normal_load"),
    ):
        change_of_datum = compliance_to_datum * series_of_instants[load]
        series_of_instants[displacement] = series_of_instants[displacement] + change_of_datum
    work = cycle_energy.work if wants_work else math.nan
    values: dict[str, Any] = {
        **series_of_instants,
        **{name: np.take(grid, number_of_distance, axis=1) for name, grid in fields.items()},
        "permanent_stick_half_width": permanent_stick(bodies, last_cycle),
        "dissipation": work,
        "loop_work": cycle_energy.loop_work if wants_work else math.nan,
        "cycle_dissipation": np.array([work]),
        "dissipation_density": density[number_of_distance],
        "steady_from": None if steady_from is None else 0,
    }
    return Findings(
        time=time,
        x=x,
        values=values,
        termination="end of path" if steady_from is None else "steady",
        message=_message(steady_from, question.scene),
        notes=tuple(_notes(rig, fine_path, last_cycle, errors, cycle_energy.odd_part)),
        errors={name: error for name, error in errors.items() if error},
        certificates=certificates_of(bodies, fields, row_numbers),
        counts={
            "points_evaluated": len(distance),
            "rows": len(fine_path.time),
            "pieces": len(fine_path.followed.pieces.top),
        },
        seconds={
            "history": history_done - started,
            "fields": clock.perf_counter() - history_done,
        },
        scene=_scene_of_loads(question.scene, rows_of_answer, last_cycle),
    )


class _Energy(NamedTuple):
    """Energy of the last cycle of a rig.

    Attributes
    ----------
    work
        friction work [energy per thickness]
    loop_work
        closed integral of Q dU + P d(approach); NaN where it does not equal the work
    odd_part
        what tilt and bulk strain of the bodies add to the work
    errors
        relative, by the name of the value
    """

    work: float
    loop_work: float
    odd_part: OddPart
    errors: dict[str, float]


def _energy_of(
    rig: Rigged,
    fine_path: Driven,
    coarse_path: Driven,
    bodies: PathSeries,
    steady_from: int | None,
) -> _Energy:
    """Friction work of the last cycle, or of a path without one, and the work of its loads, with
    their errors.

    Parameters
    ----------
    fine_path, coarse_path
        loads that were found, by steps and by steps twice as long; the difference gives the errors
    bodies
        half-widths and displacements along the fine path
    steady_from
        number of the first steady cycle, None without one
    """
    last_cycle, rows = _rows_of(fine_path, rig.scene, steady_from)
    same_loads = _SameLoads.of(rig, fine_path, last_cycle)
    odd_part = _odd_part(rig, fine_path, last_cycle, steady_from, same_loads)
    odd_work = odd_part.work(_STEADY_CYCLE)
    work = fine_path.work(last_cycle) + odd_work.value + same_loads.of_next_order
    errors = _errors(fine_path, coarse_path, steady_from)
    if work > 0:
        error_of_bodies = odd_work.uncertainty + same_loads.uncertainty
        errors["dissipation"] = errors.get("dissipation", 0.0) + error_of_bodies / work
    if odd_part.left_out:
        errors["dissipation"] = math.nan  # how much tilt and strain add is not known
    loop_work = math.nan
    # The displacement has the moment of the tilt, and not what makes the work in the second order.
    if steady_from is not None and rows.period is not None and odd_part == OddPart():
        loop_work = bodies.loop_work(last_cycle)
        coarse_cycle, _ = _rows_of(coarse_path, rig.scene, steady_from)
        if loop_work > 0:
            coarse_loop_work = _series(rig, coarse_path).loop_work(coarse_cycle)
            errors["loop_work"] = abs(coarse_loop_work / loop_work - 1)
    return _Energy(work, loop_work, odd_part, errors)


class _SameLoads(NamedTuple):
    """What the loads of a cycle that were found make of other bodies.

    Attributes
    ----------
    of_curvatures
        change of the friction work of slip by the bodies, over half-planes, minus 1
    of_next_order
        work that the next order of the bodies adds; 0 where it is left out
    uncertainty
        of the work, by the order after the next
    """

    of_curvatures: float = 0.0
    of_next_order: float = 0.0
    uncertainty: float = 0.0

    @classmethod
    def of(cls, rig: Rigged, driven: Driven, rows: slice) -> _SameLoads:
        """What the finite bodies change in the friction work of some rows of a path, under the
        loads that were found, compared with half-planes under these loads.

        Nothing for half-planes, and where the bodies slide as a whole. `driven` holds the loads.
        """
        if rig.scene.bodies.half_planes or _no_next_order(driven, rows):
            return cls()
        followed = driven.followed
        loads = (followed.normal_load, followed.tangential_load)
        table_and_loads = (followed.table, followed.friction, *loads)
        half_planes = PathSeries(
            follow(*table_and_loads, Curvatures()), rig.contact, rig.modulus, None
        )
        work_of_half_planes = half_planes.work(rows)
        if not work_of_half_planes > 0:
            return cls()
        memory_of_bodies = follow(
            *table_and_loads, curvatures_of(rig.effects), half_planes.followed
        )
        bodies = PathSeries(memory_of_bodies, rig.contact, rig.modulus, rig.effects)
        work_by_curvatures = float(np.sum(driven.slip_work[rows][1:]))
        return cls(
            of_curvatures=bodies.work(rows) / work_of_half_planes - 1,
            of_next_order=bodies.work(rows) - work_by_curvatures,
            uncertainty=work_uncertainty_by_bodies(bodies, half_planes, rows, rig.effects)
            * work_of_half_planes,
        )


def _odd_part(
    rig: Rigged,
    driven: Driven,
    last_cycle: slice,
    steady_from: int | None,
    same_loads: _SameLoads,
) -> OddPart:
    """Friction work that tilt and bulk strain of the finite bodies add in the steady cycle of a
    rig.

    Nothing where the bodies have none; left out where no cycle is steady. A numerical solution on
    grids where the second order of these small numbers does not hold.

    Parameters
    ----------
    driven
        loads and displacements that were found, step by step
    last_cycle
        the steps of the last cycle
    steady_from
        number of the first steady cycle, None without one
    same_loads
        what the bodies add under the loads that were found
    """
    if not any(getattr(rig.effects, name).value for name in ODD_NUMBERS):
        return OddPart()
    if steady_from is None:
        return OddPart(left_out="no cycle is steady")
    try:
        odd_part = OddPart(odd_part_of_rig(rig.scene, rig.effects, driven, last_cycle))
    except Declined as reason:
        odd_part = _odd_part_on_grids(rig, driven, last_cycle, str(reason))
    half_width = float(rig.contact.half_width(np.max(driven.followed.normal_load)))
    ratio_of_orders = ratio_of_next_order(rig.effects, half_width)
    return odd_part._replace(
        relative_uncertainty=uncertain_fraction_of_tilt_and_strain(
            same_loads.of_curvatures, ratio_of_orders
        )
    )


def _odd_part_on_grids(rig: Rigged, driven: Driven, last_cycle: slice, reason: str) -> OddPart:
    """Friction work that tilt and bulk strain of the finite bodies add in the last cycle of a rig,
    by a numerical solution on grids under the loads that were found.

    Used where the second order does not hold, for the `reason`. Where the contact slides as a
    whole, or grids do not take the loads, it is left out, and the result says why.
    """
    if np.any(driven.slide[last_cycle][1:] != 0):
        return OddPart(left_out=reason)
    try:
        loads_found = loads_of_cycle(rig.scene, driven, last_cycle, _STEPS_ON_GRIDS)
    except (Declined, InputError) as fault:
        return OddPart(left_out=f"{reason}, and grids do not take it: {first_line(fault)}")
    return odd_part_on_grids(loads_found, rig.effects, driven.work(last_cycle), reason)


def _no_next_order(driven: Driven, last_cycle: slice) -> str:
    """Why the next order of the bodies is left out; empty where it is not."""
    if np.any(driven.slide[last_cycle][1:] != 0):
        return "the bodies slide as a whole"
    return ""


def _to_datum_of_answers(rig: Rigged) -> float:
    """(A/pi) ln(L0/L) of half-planes: L0 is where every answer counts its displacements from, L
    where the rig prescribes them [1 / stress]; 0 of bodies.
    """
    if not rig.scene.bodies.half_planes:
        return 0.0
    ratio = rig.scene.profile.datum_length / rig.compliance.datum_length
    return rig.compliance.unit_compliance * math.log(ratio)


def _series(rig: Rigged, driven: Driven) -> PathSeries:
    """Of the curvatures, which the loads were found with."""
    effects = without_next_order(rig.effects)
    return PathSeries(driven.followed, rig.contact, rig.modulus, effects, driven.rigid_displacement)


def _followed(rig: Rigged, time: Array | None) -> tuple[Driven, Driven, int | None]:
    """Follow a rig until a cycle ends in the friction state that it started from, by steps and by
    steps twice as long; with both paths the index of that cycle, None where none does.

    Instants `time` that are asked for become rows of the fine path, and so do instants around the
    ends of gross sliding.
    """
    scene = rig.scene
    has_cycle = scene.load.path_of_actuators().period is not None
    most_cycles = max(scene.cycles, 2) if has_cycle else 0
    for cycles in range(min(2, most_cycles), most_cycles + 1):
        coarse_path = rig.follow(cycles, 1)
        is_last_try = cycles == most_cycles
        if steady_cycle(coarse_path) is None and not is_last_try:
            continue
        instants_near_ends = _near_ends_of_slides(coarse_path)
        further_instants = _within_cycles(scene, instants_near_ends, cycles)
        if len(instants_near_ends):
            coarse_path = rig.follow(cycles, 1, further_instants)
        if time is not None:
            further_instants = np.append(further_instants, _within_cycles(scene, time, cycles))
        fine_path = rig.follow(cycles, 2, further_instants)
        # Other steps may leave a little at the end of a stroke, which the next cycle takes away.
        steady_from = _steady_in_both(fine_path, coarse_path)
        if steady_from is not None or is_last_try:
            break
    return fine_path, coarse_path, steady_from if has_cycle else None


def _steady_in_both(fine_path: Driven, coarse_path: Driven) -> int | None:
    """The first cycle that is steady by both steps."""
    steady_cycles = (steady_cycle(fine_path), steady_cycle(coarse_path))
    return (
        None
        if None in steady_cycles
        else max(cycle for cycle in steady_cycles if cycle is not None)
    )


def _near_ends_of_slides(driven: Driven) -> Array:
    """Instants (k,) around those at which gross sliding ends while P varies, which the path should
    have as rows.

    There the actuator turns round against what the contact gives way. No row of the path shows that
    instant by itself.
    """
    is_sliding = driven.slide != 0
    load = driven.followed.normal_load
    last_sliding_rows = np.flatnonzero(is_sliding[1:-1] & ~is_sliding[2:]) + 1
    last_sliding_rows = last_sliding_rows[load[last_sliding_rows + 1] != load[last_sliding_rows]][
        :_MOST_ENDS
    ]
    begin_times = driven.time[last_sliding_rows - 1]
    shares_of_two_steps = np.linspace(0.0, 1.0, _ROWS_AT_END)[:, None]
    return (
        begin_times + shares_of_two_steps * (driven.time[last_sliding_rows + 1] - begin_times)
    ).ravel()


def _within_cycles(scene: Scene, time: Array, cycles: int) -> Array:
    """Instants (k,) of any cycle of the actuator's path, repeated in each of the `cycles` that are
    followed; those of the initial loading once.

    Of a path that does not repeat they are returned as they are.
    """
    path = scene.load.path_of_actuators()
    if path.period is None:
        return time
    time_since_cycle_start = np.mod(time - path.cycle_start, path.period)
    times_in_cycles = (
        path.cycle_start + time_since_cycle_start + path.period * np.arange(cycles)[:, None]
    )
    return np.concatenate([time[time < path.cycle_start], times_in_cycles.ravel()])


def steady_cycle(driven: Driven) -> int | None:
    """Index of the first cycle that ends in the friction state it started from; None where none
    does.

    The state is the memory curve, locked-in tangential force over half-width. Those at begin and
    end of the cycle must agree at many punches.
    """
    followed = driven.followed
    s_of_punches = np.linspace(0.0, followed.table.largest_s, _PLACES)
    tolerance = _STEADY * followed.friction * float(np.max(followed.normal_load))
    forces_at_ends = [followed.locked_in_force(row, s_of_punches) for row in driven.ends]
    for cycle, (forces_before, forces_after) in enumerate(pairwise(forces_at_ends)):
        if np.max(np.abs(forces_after - forces_before)) <= tolerance:
            return cycle
    return None


def _rows_of(driven: Driven, scene: Scene, steady_from: int | None) -> tuple[slice, PathRows]:
    """Which rows of a path driven by a rig the answer covers, as a slice, and the loads over time
    up to the last of them.

    Covered is the steady cycle, number `steady_from` from 0; of a path without one, all rows.
    """
    period = scene.load.path_of_actuators().period
    followed = driven.followed
    first_row = 0
    last_row = len(driven.time) - 1
    cycle_ends: tuple[int, ...] = (last_row,)
    if steady_from is None:
        period = None
    else:
        first_row = driven.ends[steady_from]
        last_row = driven.ends[steady_from + 1]
        cycle_ends = (first_row, last_row)
    rows = PathRows(
        driven.time[: last_row + 1],
        followed.normal_load[: last_row + 1],
        followed.tangential_load[: last_row + 1],
        cycle_ends,
        period,
    )
    return slice(first_row, last_row + 1), rows


def _scene_of_loads(scene: Scene, rows: PathRows, last_cycle: slice) -> Scene:
    """The scene with P and Q at the rows in the place of the displacements."""
    loads = np.stack([rows.normal_load, rows.tangential_load], axis=1)
    points = [(float(normal), float(tangential)) for normal, tangential in loads]
    loading = tuple(points[1:])
    cycle: tuple[tuple[float, float], ...] = ()
    if rows.period is not None:
        loading = tuple(points[1 : last_cycle.start + 1])
        cycle = tuple(points[last_cycle.start + 1 : -1])
    load = PolygonLoad(initial_loading=loading, cycle=cycle, times=tuple(rows.time.tolist()))
    return scene.vary(load=load, rig=Rig(), cycles=1)


def _errors(fine_path: Driven, coarse_path: Driven, steady_from: int | None) -> dict[str, float]:
    """Relative errors of friction work and of Q by the steps: differences between a path by steps
    and by steps twice as long.

    That of the work is over W of the steady cycle `steady_from`, or of the path where there is
    none; that of Q over the largest |Q|.
    """
    errors = {}
    rows_of_fine = slice(0, None)
    if steady_from is not None:
        rows_of_fine = slice(fine_path.ends[steady_from], fine_path.ends[steady_from + 1] + 1)
    rows_of_coarse = slice(0, None)
    if steady_from is not None:
        rows_of_coarse = slice(coarse_path.ends[steady_from], coarse_path.ends[steady_from + 1] + 1)
    work = fine_path.work(rows_of_fine)
    if work > 0:
        errors["dissipation"] = abs(coarse_path.work(rows_of_coarse) / work - 1)
    force = fine_path.followed.tangential_load
    largest_force = float(np.max(np.abs(force)))
    if largest_force > 0:
        _, row_numbers, row_numbers_in_coarse = np.intersect1d(
            fine_path.time, coarse_path.time, return_indices=True
        )
        difference = (
            force[row_numbers] - coarse_path.followed.tangential_load[row_numbers_in_coarse]
        )
        errors["tangential_load"] = float(np.max(np.abs(difference))) / largest_force
    return errors


def _message(steady_from: int | None, scene: Scene) -> str:
    """How the path ended, in a sentence."""
    if steady_from is not None:
        return f"cycle {steady_from + 1} ends in the state it started from"
    if scene.load.path_of_actuators().period is None:
        return "the path was followed to its end"
    return f"no steady cycle among the first {max(scene.cycles, 2)}: the whole path is answered"


# ---------------------------------------------------------------------------------------- the words
def _notes(
    rig: Rigged, driven: Driven, last_cycle: slice, errors: dict[str, float], odd_part: OddPart
) -> Iterator[str]:
    """Sentences on what a reader of the answer to a rig must not miss: where displacements are
    prescribed, what is left out, what the spring takes, slides and separations.

    Parameters
    ----------
    driven
        loads and displacements that were found, step by step
    last_cycle
        the steps of the last cycle
    errors
        relative errors by the name of the value
    odd_part
        what tilt and bulk strain of the bodies add to the work
    """
    scene = rig.scene
    force_unit, length_unit, _ = scene.unit_words
    yield from neglected_coupling(scene.material)
    if scene.bodies.half_planes:
        yield (
            "rig: the displacements are prescribed at half-planes, in the distance"
            f" {rig.effects.datum_length:.6g} {length_unit} from the contact; U and approach here"
            f" count from {scene.profile.datum_length:.6g} {length_unit}, as in every answer"
        )
    else:
        yield (
            "rig: the displacements are prescribed at the bases of the bodies; corrected theory is"
            " implied"
        )
        half_width = float(rig.contact.half_width(np.max(driven.followed.normal_load)))
        modulus = composite_modulus(scene.material)
        if has_next_order(rig.effects):
            yield _note_of_next_order(rig, driven, last_cycle)
        yield from notes_of_effects(rig.effects, half_width, modulus, odd_part, OF_RIG)
    spring = rig.compliance.tangential_spring
    if spring:
        actuator_range = float(np.ptp(driven.actuator[last_cycle]))
        contact_range = float(np.ptp(driven.displacement[last_cycle]))
        yield (
            f"rig: of the range {actuator_range:.6g} {length_unit} of the actuator the contact"
            f" takes {contact_range:.6g}, the spring the rest"
        )
    largest_force = float(np.max(np.abs(driven.followed.tangential_load)))
    yield (
        "rig: P and Q follow from the displacements, at constant P without an error of the steps;"
        f" here Q is uncertain by {errors.get('tangential_load', 0.0) * largest_force:.2g} of at"
        f" most {largest_force:.6g} {force_unit}/{length_unit}"
    )
    yield from notes_of_slides(scene, driven, last_cycle)
    if np.any(driven.followed.normal_load[1:] <= 0):
        yield "separation: the bodies part, and nothing is remembered after it"


def _note_of_next_order(rig: Rigged, driven: Driven, last_cycle: slice) -> str:
    """A sentence on the next order of the finite bodies' effects, beyond their curvatures: where it
    counts, and by how much it would change the largest pressure and half-width.

    `rig` holds the contact with the effects of its bodies, `driven` the loads that were found, and
    `last_cycle` are their rows of the last cycle.
    """
    left_out = _no_next_order(driven, last_cycle)
    place_text = f"left out: {left_out}" if left_out else "in the dissipation"
    rows = np.array([0.0, np.max(driven.followed.normal_load)])
    effects_without = without_next_order(rig.effects)
    pressures = []
    half_widths = []
    for effects in (rig.effects, effects_without):
        memory = follow(driven.followed.table, 1.0, rows, 0 * rows, curvatures_of(effects))
        series = PathSeries(memory, rig.contact, rig.modulus, effects)
        half_width = float(series.half_width[1])
        places = np.linspace(0.0, half_width, _PLACES)
        pressures.append(float(np.max(PointFields(series, places).pressure(np.array([1])))))
        half_widths.append(half_width)
    return (
        f"effects: the next order of the bodies, N_4, T_4, N_22 and T_22, is {place_text}, and in"
        " no other value: of the largest pressure it would make"
        f" {100 * (pressures[0] / pressures[1] - 1):+.2g} %, of the largest half-width"
        f" {100 * (half_widths[0] / half_widths[1] - 1):+.2g} %"
    )


def notes_of_slides(scene: Scene, driven: Driven, last_cycle: slice) -> Iterator[str]:
    """Sentences on when the bodies slide as a whole, how far and with what friction work: in the
    last cycle, and before it.

    Of a path without cycles, along all of it. `driven` holds the slides row by row.
    """
    force_unit, length_unit, _ = scene.unit_words
    energy_unit = f"{force_unit}·{length_unit}/{length_unit}"
    span_text = "the last cycle" if last_cycle.start else "the path"
    slides = slides_of(driven, last_cycle)
    slides_before = slides_of(driven, slice(0, last_cycle.start + 1)) if last_cycle.start else []
    if not slides:
        yield f"gross sliding: none in {span_text}"
    else:
        slide_distance = sum(abs(slide.distance) for slide in slides)
        work = sum(slide.work for slide in slides)
        named_slides = "; ".join(_in_words(slide, length_unit) for slide in slides[:_MOST_NAMED])
        rest_text = f"; and {len(slides) - _MOST_NAMED} more" if len(slides) > _MOST_NAMED else ""
        yield (
            f"gross sliding: in {span_text} the bodies slide as a whole by {slide_distance:.6g}"
            f" {length_unit}, which takes {work:.6g} {energy_unit} of the dissipation:"
            f" {named_slides}{rest_text}"
        )
    if slides_before:
        yield (
            "gross sliding: before it"
            f" {'; '.join(_in_words(s, length_unit) for s in slides_before[:2])}"
        )


def _in_words(slide: _Slide, length: str) -> str:
    direction = "forward" if slide.distance > 0 else "back"
    return (
        f"from time {slide.begin:.6g} to {slide.end:.6g} {direction} by {abs(slide.distance):.6g}"
        f" {length}"
    )
