"""The answer to a scene whose rig prescribes displacements, as `Findings`: the loads P and Q that
follow from them, of `driven`, and the fields of corrected half-plane theory under these loads.

The answer's scene states the loads that were found, in the place of the displacements: a polygon
with a point for each instant. Cycles before the steady one are part of its initial loading.

A path is followed twice: by fine steps, which give the values, and by steps twice as long, which
give their errors. At constant P the friction work W does not depend on the steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import BodyEffects, Hertz, InputError, PolygonLoad, Rig, Scene
from scenes.array_types import Array
from scenes.errors import first_line
from semi_analytic.answer import Findings, Question, StopWatch, mirrored_points, neglected_coupling
from semi_analytic.corrected import (
    WORDS_UNDER_RIG,
    FieldsByDistance,
    PathRows,
    PathSeries,
    PointFields,
    TiltAndStrainPart,
    admissibility_checks_of,
    curvatures_of,
    instants_and_row_numbers,
    notes_of_effects,
    permanent_stick_half_width,
    punch_table_of,
    tilt_and_strain_part_on_grids,
    values_over_time_at,
    work_uncertainty_by_bodies,
)
from semi_analytic.corrected_memory import Curvatures, PunchTable, follow
from semi_analytic.driven import (
    ActuatorRows,
    Compliance,
    DrivenPath,
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
from semi_analytic.odd_memory import TILT_AND_STRAIN_NAMES, DeclinedError
from semi_analytic.odd_part_of_rig import loads_of_cycle, second_order_answer_of_rig
from semi_analytic.profiles import SymmetricContact, contact_of

# Points among which the largest pressure is sought.
_SAMPLED_PLACES = 200
# Rows on the two steps around the end of a slide, and ends that have them.
_ROWS_AT_SLIDE_END = 33
_MOST_SLIDE_ENDS = 200
# Sliding distances up to this share of the actuator's range are round-off.
_ROUND_OFF_SLIDE_SHARE = 1e-9
# Straight steps of a cycle on grids, which take few.
_STEPS_ON_GRIDS = 55
# Index of a steady cycle in a repeated path of `second_order_answer_of_rig`: the second, if not the
# first.
_INDEX_OF_STEADY_CYCLE = 1
# Slides that a note names one by one.
_MOST_SLIDES_NAMED = 4


# ------------------------------------------------------------------------------------ the movements
@dataclass(frozen=True, eq=False)
class RiggedScene:
    """A scene whose rig prescribes displacements, with what is needed to follow it.

    Attributes
    ----------
    scene
        as asked
    contact
        normal contact of half-planes
    modulus
        E* [stress]
    effects
        what the bodies add to half-planes
    compliance
        of contact, bodies and springs of the rig, with the curvatures that the bodies add
    """

    scene: Scene
    contact: SymmetricContact
    modulus: float
    effects: BodyEffects
    compliance: Compliance

    def driven_path(
        self, n_cycles: int, refinement: int, extra_times: Array | None = None
    ) -> DrivenPath:
        """Loads and gross sliding along the path of the actuators of the rig over so many cycles.

        Parameters
        ----------
        n_cycles
            number of cycles after the initial loading
        refinement
            factor on the least number of steps
        extra_times
            (k,) more instants at which a step ends; None: no more
        """
        path = self.scene.load.path_of_actuators()
        return self.driven_path_of_rows(actuator_rows(path, n_cycles, refinement, extra_times))

    def driven_path_of_rows(self, actuator_motion: ActuatorRows) -> DrivenPath:
        """Loads P and Q and gross sliding along a path of the actuators that is given by the ends
        of its steps.

        `actuator_motion` are these instants with P, or the normal approach in its place, and the
        displacement U_act of the tangential actuator. InputError where the bodies never touch, or
        where the displacement of an actuator does not determine its load.
        """
        # states_approach: whether the normal approach is prescribed, in the place of P.
        scene = self.scene
        if scene.load.states_approach:
            normal_loads = loads_of_approach(
                self.contact, self.modulus, self.compliance, actuator_motion.load_or_approach
            )
            actuator_motion = actuator_motion._replace(load_or_approach=normal_loads)
        # Flat punches of the contact; largest_s: coordinate s of the widest of them.
        table = self._punch_table(actuator_motion)
        largest_load = float(np.max(actuator_motion.load_or_approach))
        self.compliance.require_unique_force(float(table.half_width(table.largest_s)), largest_load)
        return follow_actuator(table, scene.friction.coefficient, self.compliance, actuator_motion)

    def _punch_table(self, actuator_motion: ActuatorRows) -> PunchTable:
        """Table of the flat punches that make up the contact, up to its largest half-width for any
        Q within the Coulomb limit. InputError where P is never positive.
        """
        if not np.any(actuator_motion.load_or_approach > 0):
            raise InputError(
                "load: P is never positive, so that the bodies never touch; it is a compression"
            )
        # Curvatures that the bodies add per load; normal_under_shear: N_Q, of the gap per Q.
        curvatures_per_load = self.compliance.curvatures
        friction_limit = self.scene.friction.coefficient * actuator_motion.load_or_approach
        # The Q at the Coulomb limit that widens the contact.
        widening_force = -np.sign(curvatures_per_load.normal_under_shear) * friction_limit
        path_rows = PathRows(
            actuator_motion.time,
            actuator_motion.load_or_approach,
            widening_force,
            actuator_motion.end_rows,
            None,
        )
        return punch_table_of(self.contact, self.modulus, path_rows, curvatures_per_load)


def rigged_scene(scene: Scene, effects: BodyEffects | None) -> RiggedScene:
    """A scene whose rig prescribes displacements, with its normal contact on half-planes, E*, and
    the compliance of contact, bodies and springs of the rig.

    `effects` are what finite bodies add to half-planes: compliances, tilt and curvatures of the
    faces by the loads. Without them half-planes get those of the rig's datum length alone.

    Raises
    ------
    InputError
        For finite bodies without their effects.
    """
    # The rig has a stiffness of each spring, None if it is stiff, and a datum length.
    rig_of_scene = scene.rig
    if effects is None:
        if not scene.bodies.half_planes:
            raise InputError(
                "load.tangential_displacement: the displacement of these bodies is not that of"
                " half-planes; give effects = halfplane_fe.body_effects(scene)"
            )
        assert rig_of_scene.datum_length is not None  # for the type checker: the scene was checked
        effects = BodyEffects(datum_length=rig_of_scene.datum_length)
    modulus = composite_modulus(scene.material)
    # unit_compliance: A/pi; a stiff rig has no stiffness stated: its spring compliance is 0.
    compliance = Compliance(
        unit_compliance=2 / (math.pi * modulus),
        datum_length=effects.datum_length,
        normal_body_compliance=effects.normal_compliance.value,
        tangential_body_compliance=effects.tangential_compliance.value,
        normal_spring_compliance=1 / (rig_of_scene.normal_stiffness or math.inf),
        tangential_spring_compliance=1 / (rig_of_scene.tangential_stiffness or math.inf),
        curvatures=curvatures_of(effects),
        tilt_products=_tilt_products_of(scene, effects),
    )
    contact = contact_of(scene.profile, scene.material)
    return RiggedScene(scene, contact, modulus, effects, compliance)


def _tilt_products_of(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
    """Effect of tilt on the displacement of a parabola of radius R: R alpha_P alpha_Q and R
    alpha_Q^2 [1 / (stress load)], alpha_P and alpha_Q the tilt of the faces by a unit of P and Q.

    0 for other profiles: the moment under a tilt is known of the parabola alone.
    """
    if not isinstance(scene.profile, Hertz):
        return 0.0, 0.0
    tilt_under_shear = effects.tilt_under_shear.value
    tilt_under_pressure = effects.tilt_under_pressure.value
    radius = scene.profile.radius
    return radius * tilt_under_pressure * tilt_under_shear, radius * tilt_under_shear**2


class _Slide(NamedTuple):
    """An interval of gross sliding, in one direction, of one load step or more."""

    begin: float  # time
    end: float
    distance: float  # signed, of the upper body over the lower along +x [length]
    work: float  # integral of f P over the distance [energy / thickness]


def slides_of(driven_path: DrivenPath, row_range: slice) -> list[_Slide]:
    """Intervals of gross sliding, in which the bodies slide as a whole, within some rows of a path
    driven by an actuator: begin, end, distance and friction work of each.

    A row is an instant at the end of a load step; the step up to the first of the `row_range` does
    not count. Neighbouring steps that slide in one direction make one interval. A sliding distance
    below 1e-9 of the actuator's range is round-off.

    Parameters
    ----------
    driven_path
        for each row the time, the sliding distance and friction work of the step that ends there,
        and the displacement of the actuator, (n,) each
    row_range
        rows of the path that are looked at
    """
    # Sign of the slide of each step, 0 for round-off.
    row_numbers = np.arange(len(driven_path.time))[row_range]
    actuator_range = float(np.ptp(driven_path.actuator_displacement)) or 1.0
    slide_direction = np.sign(driven_path.slide_distance)
    largest_round_off = _ROUND_OFF_SLIDE_SHARE * actuator_range
    slide_direction[np.abs(driven_path.slide_distance) <= largest_round_off] = 0
    slides: list[_Slide] = []
    for row_before, row in pairwise(row_numbers.tolist()):
        if not slide_direction[row]:
            continue
        slide_in_step = _Slide(
            float(driven_path.time[row_before]),
            float(driven_path.time[row]),
            float(driven_path.slide_distance[row]),
            float(driven_path.slide_work[row]),
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
def findings_of_rig(question: Question) -> Findings:
    """Half-plane answer, corrected for finite bodies, to a scene whose rig prescribes
    displacements: loads P and Q, fields, friction work of the steady cycle, and their errors.

    The answer covers the first steady cycle, or the whole path where no cycle is steady. The loads
    are found step by step, and again by steps twice as long; the difference is stated as error.
    Fields are those of half-planes with the curvatures of the bodies, under these loads. The
    friction work also has what tilt, bulk strain and the terms in x^4 of the bodies add.

    Parameters
    ----------
    question
        the scene with its rig, points, instants and fields that are wanted, and the effects of the
        finite bodies, None for half-planes

    Raises
    ------
    InputError
        For `straight_steps`, for materials, profiles or rigs that corrected theory does not take,
        and for springs with which the displacements do not determine Q.
    """
    stop_watch = StopWatch("history", "fields")
    if question.straight_steps:
        raise InputError(
            "straight_steps: it goes with given loads; leave it out where a displacement is"
            " prescribed"
        )

    followed_rig = _FollowedRig.of_question(question)
    stop_watch.add_lap("history")
    # instants, points, and the values at them
    time, row_numbers = instants_and_row_numbers(
        question, followed_rig.loads_up_to_end, followed_rig.last_cycle
    )
    x = question.x
    if x is None:
        x = mirrored_points(1.05 * float(np.max(followed_rig.corrected_path.half_width)))
    fields = FieldsByDistance.of_question(question, followed_rig.corrected_path, x, row_numbers)
    # friction work of the last cycle, the closed integral of Q dU + P d(approach), their errors
    cycle_energy = _energy_of(followed_rig)
    stop_watch.add_lap("fields")
    is_steady = followed_rig.steady_from is not None
    return Findings(
        time=time,
        x=x,
        values={
            **_values_from_answer_datum(question, followed_rig, row_numbers),
            **fields.by_name,
            **_works_by_name(question, cycle_energy),
            "permanent_stick_half_width": permanent_stick_half_width(
                followed_rig.corrected_path, followed_rig.last_cycle
            ),
            "dissipation_density": _density_of_last_cycle(question, followed_rig, fields),
            # The answer covers the steady cycle alone: its cycle number 0.
            "steady_from": 0 if is_steady else None,
        },
        termination="steady" if is_steady else "end of path",
        message=_message(followed_rig.steady_from, question.scene),
        notes=tuple(_notes(followed_rig, cycle_energy)),
        errors={name: error for name, error in cycle_energy.errors.items() if error},
        certificates=admissibility_checks_of(
            followed_rig.corrected_path, fields.at_distances, row_numbers
        ),
        counts={"points_evaluated": len(fields.distance), **followed_rig.corrected_path.counts},
        seconds=stop_watch.seconds,
        scene=_scene_of_loads(
            question.scene, followed_rig.loads_up_to_end, followed_rig.last_cycle
        ),
    )


@dataclass(frozen=True, eq=False)
class _FollowedRig:
    """A rig whose actuators were followed: the loads that were found, and which part of the path
    the answer covers.

    Attributes
    ----------
    rig
        scene with its rig, contact and the effects of its bodies
    fine_path, coarse_path
        loads and displacements by steps, and by steps twice as long; the difference gives the
        errors
    steady_from
        index of the first steady cycle, None without one
    last_cycle
        rows of the fine path, the ends of its steps, that the answer covers: the first steady
        cycle, with the row at which it begins; the whole path where no cycle is steady
    loads_up_to_end
        P and Q at all rows up to the last of these
    corrected_path
        half-widths and displacements of the fine path, with the curvatures of the bodies
    """

    rig: RiggedScene
    fine_path: DrivenPath
    coarse_path: DrivenPath
    steady_from: int | None
    last_cycle: slice
    loads_up_to_end: PathRows
    corrected_path: PathSeries

    @classmethod
    def of_question(cls, question: Question) -> _FollowedRig:
        """Follow the actuators of a question's scene, with the effects of its finite bodies, None
        for half-planes. The instants `time` of the question are ends of steps; None for none.

        Raises
        ------
        InputError
            For finite bodies without their effects, bodies that never touch, and displacements that
            do not determine the loads.
        """
        rig = rigged_scene(question.scene, question.effects)
        fine_path, coarse_path, steady_from = _fine_and_coarse_paths(rig, question.time)
        last_cycle, loads_up_to_end = _rows_of_answer(fine_path, question.scene, steady_from)
        return cls(
            rig=rig,
            fine_path=fine_path,
            coarse_path=coarse_path,
            steady_from=steady_from,
            last_cycle=last_cycle,
            loads_up_to_end=loads_up_to_end,
            corrected_path=_corrected_path(rig, fine_path),
        )

    @property
    def largest_load(self) -> float:
        """The largest P of the whole path [force per thickness]."""
        return float(np.max(self.fine_path.followed_path.normal_load))


def _density_of_last_cycle(
    question: Question, followed_rig: _FollowedRig, fields: FieldsByDistance
) -> Array:
    """Friction work per area W(x) of the last cycle of a rig at the m points of the answer, (m,)
    [energy per area]. NaN where the question does not want it.
    """
    if not question.wants("dissipation_density"):
        return np.full(len(fields.distance_index), np.nan)
    return np.asarray(fields.at_points(fields.point_fields.work_density(followed_rig.last_cycle)))


def _values_from_answer_datum(
    question: Question, followed_rig: _FollowedRig, row_numbers: NDArray[np.int64]
) -> dict[str, Array]:
    """Loads, displacements, half-widths (n,) and edges (n, 2) at the rows of a followed path with
    these numbers (n,), by their names in a solution.

    The rig prescribes displacements at its own datum length; the answer counts them from that of
    the profile. The question holds which displacements are wanted, the others are NaN.
    """
    values_over_time = values_over_time_at(question, followed_rig.corrected_path, row_numbers)
    compliance_to_datum = _compliance_to_answer_datum(followed_rig.rig)
    for displacement_name, load_name in (
        ("tangential_displacement", "tangential_load"),
        ("normal_approach", "normal_load"),
    ):
        datum_shift = compliance_to_datum * values_over_time[load_name]
        values_over_time[displacement_name] = values_over_time[displacement_name] + datum_shift
    return values_over_time


def _works_by_name(question: Question, cycle_energy: _Energy) -> dict[str, float | Array]:
    """Friction work and closed integral of the loads of the last cycle [energy per thickness], by
    their names in a solution. NaN where the question does not want the friction work.
    """
    wants_work = question.wants("dissipation")
    work = cycle_energy.work if wants_work else math.nan
    return {
        "dissipation": work,
        "loop_work": cycle_energy.loop_work if wants_work else math.nan,
        "cycle_dissipation": np.array([work]),
    }


class _Energy(NamedTuple):
    """Energy of the last cycle of a rig.

    Attributes
    ----------
    work
        friction work [energy per thickness]
    loop_work
        closed integral of Q dU + P d(approach); NaN where it does not equal the work
    part_by_tilt_and_strain
        what tilt and bulk strain of the bodies add to the work, or why it is left out
    errors
        relative, by the name of the value
    """

    work: float
    loop_work: float
    part_by_tilt_and_strain: TiltAndStrainPart
    errors: dict[str, float]


def _energy_of(followed_rig: _FollowedRig) -> _Energy:
    """Energy of the last cycle of a rig, or of all of a path that has no steady cycle: friction
    work, closed integral of the loads over their displacements, and relative errors.

    The work [energy per thickness] is the sum of three: the work by steps, what tilt and bulk
    strain of the bodies add, and what the terms in x^4 beyond their curvatures add. The closed
    integral is NaN without a steady cycle, and with tilt or bulk strain. The error of the work is
    NaN where what tilt and strain add is not known.
    """
    change_by_bodies = _ChangeByBodies.of_driven_path(
        followed_rig.rig, followed_rig.fine_path, followed_rig.last_cycle
    )
    part_by_tilt_and_strain = _part_by_tilt_and_strain(followed_rig, change_by_bodies)
    # in the steady cycle, index 1 of a path that repeats it
    work_of_tilt_and_strain = part_by_tilt_and_strain.work(_INDEX_OF_STEADY_CYCLE)
    total_work = (
        followed_rig.fine_path.work(followed_rig.last_cycle)
        + work_of_tilt_and_strain.value
        + change_by_bodies.work_of_next_order
    )

    # By name: change of values from coarse to fine steps; the uncertainty by the bodies is added.
    errors = _errors_of_steps(
        followed_rig.fine_path, followed_rig.coarse_path, followed_rig.steady_from
    )
    if total_work > 0:
        error_of_bodies = work_of_tilt_and_strain.uncertainty + change_by_bodies.work_uncertainty
        errors["dissipation"] = errors.get("dissipation", 0.0) + error_of_bodies / total_work
    if part_by_tilt_and_strain.left_out:  # the reason, if that work is not known
        errors["dissipation"] = math.nan

    loop_work = math.nan
    # With tilt or bulk strain the closed integral is another number than the work: of their changes
    # U contains the moment of the pressure alone, which is not all that adds to the work.
    if part_by_tilt_and_strain == TiltAndStrainPart():
        loop_work, loop_error = _loop_work_and_error(followed_rig)
        if loop_error is not None:
            errors["loop_work"] = loop_error
    return _Energy(total_work, loop_work, part_by_tilt_and_strain, errors)


def _loop_work_and_error(followed_rig: _FollowedRig) -> tuple[float, float | None]:
    """Closed integral of Q dU + P d(approach) over the steady cycle of a rig [energy per
    thickness], and its relative error: its change by steps twice as long.

    NaN without a steady cycle, where the loads have no `period`. The error is None where the
    integral is not above 0. U is the tangential displacement.
    """
    steady_from = followed_rig.steady_from
    if steady_from is None or followed_rig.loads_up_to_end.period is None:
        return math.nan, None
    loop_work = followed_rig.corrected_path.loop_work(followed_rig.last_cycle)
    if not loop_work > 0:
        return loop_work, None
    coarse_path = followed_rig.coarse_path
    coarse_cycle, _ = _rows_of_answer(coarse_path, followed_rig.rig.scene, steady_from)
    coarse_loop_work = _corrected_path(followed_rig.rig, coarse_path).loop_work(coarse_cycle)
    return loop_work, abs(coarse_loop_work / loop_work - 1)


class _ChangeByBodies(NamedTuple):
    """Change of the friction work of slip in a cycle by finite bodies, against half-planes, under
    the loads that were found for the bodies.

    Attributes
    ----------
    relative_change
        W of the bodies over W of half-planes, minus 1
    work_of_next_order
        work that the terms beyond the curvatures add [energy per thickness]; 0 where they are left
        out
    work_uncertainty
        of the work, by the terms that the bodies' effects leave out [energy per thickness]
    """

    relative_change: float = 0.0
    work_of_next_order: float = 0.0
    work_uncertainty: float = 0.0

    @classmethod
    def of_driven_path(
        cls, rig: RiggedScene, driven_path: DrivenPath, cycle_rows: slice
    ) -> _ChangeByBodies:
        """Change of the friction work by the finite bodies of a rig, in some rows of a path,
        against half-planes under the same P and Q; without gross sliding.

        The effects of the bodies are a series in x: curvatures of the faces, x^2, then the next
        order, x^4. All values are 0 for half-planes, where the bodies slide as a whole, and where
        half-planes would do no work.

        Parameters
        ----------
        rig
            scene with contact, E* and the effects of its bodies
        driven_path
            path with the loads, which were found with curvatures alone
        cycle_rows
            rows of the path, the ends of its steps
        """
        if rig.scene.bodies.half_planes or _reason_without_next_order(driven_path, cycle_rows):
            return cls()
        # The same loads three times: half-planes; bodies with all terms; bodies with curvatures
        # alone. followed_path_of_rig: P, Q and friction memory at each row, table of flat punches.
        followed_path_of_rig = driven_path.followed_path
        normal_and_tangential_loads = (
            followed_path_of_rig.normal_load,
            followed_path_of_rig.tangential_load,
        )
        table_and_loads = (
            followed_path_of_rig.table,
            followed_path_of_rig.friction,
            *normal_and_tangential_loads,
        )
        path_of_half_planes = PathSeries(
            follow(*table_and_loads, Curvatures()), rig.contact, rig.modulus, None
        )
        work_of_half_planes = path_of_half_planes.work(cycle_rows)
        if not work_of_half_planes > 0:
            return cls()
        memory_of_bodies = follow(
            *table_and_loads, curvatures_of(rig.effects), path_of_half_planes.followed_path
        )
        path_with_bodies = PathSeries(memory_of_bodies, rig.contact, rig.modulus, rig.effects)
        work_of_bodies = path_with_bodies.work(cycle_rows)

        # slip_work: of the step that ends at each row; that of the first row is before the cycle.
        work_with_curvatures_alone = float(np.sum(driven_path.slip_work[cycle_rows][1:]))
        relative_uncertainty = work_uncertainty_by_bodies(
            path_with_bodies, path_of_half_planes, cycle_rows, rig.effects
        )
        return cls(
            relative_change=work_of_bodies / work_of_half_planes - 1,
            work_of_next_order=work_of_bodies - work_with_curvatures_alone,
            work_uncertainty=relative_uncertainty * work_of_half_planes,
        )


def _part_by_tilt_and_strain(
    followed_rig: _FollowedRig, change_by_bodies: _ChangeByBodies
) -> TiltAndStrainPart:
    """Friction work that tilt and bulk strain of the finite bodies add in the steady cycle of a rig
    [energy per thickness].

    It is taken to the second order in tilt and strain, or from a numerical solution on grids where
    that does not hold. It is 0 where the bodies have neither tilt nor strain. It is left out, with
    the reason, where no cycle is steady. `change_by_bodies` is what curvatures change of the
    friction work, which makes that of tilt and strain uncertain.
    """
    rig = followed_rig.rig
    fine_path = followed_rig.fine_path
    last_cycle = followed_rig.last_cycle
    # TILT_AND_STRAIN_NAMES: attributes of the effects with tilt and strain per P and per Q.
    if not any(getattr(rig.effects, name).value for name in TILT_AND_STRAIN_NAMES):
        return TiltAndStrainPart()
    if followed_rig.steady_from is None:
        return TiltAndStrainPart(left_out="no cycle is steady")
    try:
        part_by_tilt_and_strain = TiltAndStrainPart(
            second_order_answer_of_rig(rig.scene, rig.effects, fine_path, last_cycle)
        )
    except DeclinedError as reason:
        part_by_tilt_and_strain = _part_by_tilt_and_strain_on_grids(
            rig, fine_path, last_cycle, str(reason)
        )
    # a at the largest P, and the ratio of the fourth order to the curvatures there
    half_width = float(rig.contact.half_width(followed_rig.largest_load))
    ratio_of_orders = ratio_of_next_order(rig.effects, half_width)
    return part_by_tilt_and_strain._replace(
        relative_uncertainty=uncertain_fraction_of_tilt_and_strain(
            change_by_bodies.relative_change, ratio_of_orders
        )
    )


def _part_by_tilt_and_strain_on_grids(
    rig: RiggedScene, driven_path: DrivenPath, last_cycle: slice, reason: str
) -> TiltAndStrainPart:
    """Friction work that tilt and bulk strain of the finite bodies add in the last cycle of a rig
    [energy per thickness]. It comes from a numerical solution on grids under the loads that were
    found.

    Used where the second order in tilt and strain does not hold. Where the contact slides as a
    whole, or grids cannot solve the loads, the work is left out, and `left_out` states why.

    Parameters
    ----------
    rig
        scene with its rig and the effects of its bodies
    driven_path
        the path with P and Q, and the gross sliding of the step that ends at each row
    last_cycle
        rows of the last cycle
    reason
        why the second order does not hold
    """
    if np.any(driven_path.slide_distance[last_cycle][1:] != 0):
        return TiltAndStrainPart(left_out=reason)
    # The loads of the cycle, at most 55 straight steps of them, in the place of the displacements.
    try:
        scene_of_loads = loads_of_cycle(rig.scene, driven_path, last_cycle, _STEPS_ON_GRIDS)
    except (DeclinedError, InputError) as fault:
        return TiltAndStrainPart(
            left_out=f"{reason}, and grids do not take it: {first_line(fault)}"
        )
    return tilt_and_strain_part_on_grids(
        scene_of_loads, rig.effects, driven_path.work(last_cycle), reason
    )


def _reason_without_next_order(driven_path: DrivenPath, last_cycle: slice) -> str:
    """Why the terms of the bodies' effects beyond their curvatures are left out of the friction
    work; empty where they are in it.
    """
    if np.any(driven_path.slide_distance[last_cycle][1:] != 0):
        return "the bodies slide as a whole"
    return ""


def _compliance_to_answer_datum(rig: RiggedScene) -> float:
    """Compliance (A/pi) ln(L0/L) of half-planes between two datum lengths [1 / stress]; 0 for
    finite bodies.

    L0 is the datum length of the displacements in every answer, L that at which the rig prescribes
    them. `rig.compliance` holds L and the compliance A/pi of half-planes,
    `rig.scene.profile` L0.
    """
    if not rig.scene.bodies.half_planes:
        return 0.0
    datum_length_ratio = rig.scene.profile.datum_length / rig.compliance.datum_length
    return rig.compliance.unit_compliance * math.log(datum_length_ratio)


def _corrected_path(rig: RiggedScene, driven_path: DrivenPath) -> PathSeries:
    """Half-widths, displacements and work along a path of a rig, with the curvatures that its
    bodies give to the faces; the loads were found with the same curvatures.

    `driven_path` holds the memory of friction along the path, and the displacement by gross sliding
    and separation, (n,).
    """
    effects = without_next_order(rig.effects)
    return PathSeries(
        driven_path.followed_path, rig.contact, rig.modulus, effects, driven_path.rigid_displacement
    )


def _fine_and_coarse_paths(
    rig: RiggedScene, time: Array | None
) -> tuple[DrivenPath, DrivenPath, int | None]:
    """Loads and gross sliding of a rig by fine steps and by steps twice as long, and the index of
    the first steady cycle; None without one.

    A steady cycle ends in the friction state that it started from. Cycles are added until one is
    steady by both kinds of steps. The instants of the answer are rows (ends of steps) of the fine
    path. Instants around the ends of gross sliding are rows of both.

    Parameters
    ----------
    rig
        scene with its rig, which follows its actuators by steps
    time
        (n,) instants of the answer, or None
    """
    scene = rig.scene
    has_cycle = scene.load.path_of_actuators().period is not None
    # Two cycles are tried first, then more, up to the number of the scene.
    most_cycles = max(scene.cycles, 2) if has_cycle else 0
    for n_cycles in range(min(2, most_cycles), most_cycles + 1):
        coarse_path = rig.driven_path(n_cycles, refinement=1)
        is_last_try = n_cycles == most_cycles
        if coarse_path.first_steady_cycle is None and not is_last_try:
            continue
        # More rows where gross sliding ends within a step, in all cycles.
        times_near_ends = _times_near_slide_ends(coarse_path)
        further_times = _times_in_all_cycles(scene, times_near_ends, n_cycles)
        if len(times_near_ends):
            coarse_path = rig.driven_path(n_cycles, 1, further_times)
        if time is not None:
            further_times = np.append(further_times, _times_in_all_cycles(scene, time, n_cycles))
        fine_path = rig.driven_path(n_cycles, 2, further_times)
        # A cycle that is steady by the coarse steps may not be so by the fine ones: at the end of a
        # stroke these may lock in a little force that slip takes away in the next cycle.
        steady_from = _steady_in_both(fine_path, coarse_path)
        if steady_from is not None or is_last_try:
            break
    return fine_path, coarse_path, steady_from if has_cycle else None


def _steady_in_both(fine_path: DrivenPath, coarse_path: DrivenPath) -> int | None:
    """Index of the first cycle that is steady on the fine and on the coarse path; None where one of
    them has no steady cycle.
    """
    fine_cycle = fine_path.first_steady_cycle
    coarse_cycle = coarse_path.first_steady_cycle
    if fine_cycle is None or coarse_cycle is None:
        return None
    return max(fine_cycle, coarse_cycle)


def _times_near_slide_ends(driven_path: DrivenPath) -> Array:
    """Times (k,) around each end of gross sliding while P varies, at which the path needs further
    rows. They are 33 over the last step with a slide and the step after it.

    Sliding ends where the actuator no longer moves faster than the elastic displacement at |Q| =
    f P. While P varies that instant lies inside of a step. Only the first 200 ends get rows.
    `driven_path` has for each row the time, P, and the slide of the step that ends there.
    """
    is_sliding = driven_path.slide_distance != 0
    normal_load = driven_path.followed_path.normal_load
    last_sliding_rows = np.flatnonzero(is_sliding[1:-1] & ~is_sliding[2:]) + 1
    load_varies = normal_load[last_sliding_rows + 1] != normal_load[last_sliding_rows]
    last_sliding_rows = last_sliding_rows[load_varies][:_MOST_SLIDE_ENDS]
    begin_times = driven_path.time[last_sliding_rows - 1]
    end_times = driven_path.time[last_sliding_rows + 1]
    fractions_of_two_steps = np.linspace(0.0, 1.0, _ROWS_AT_SLIDE_END)[:, None]
    return (begin_times + fractions_of_two_steps * (end_times - begin_times)).ravel()


def _times_in_all_cycles(scene: Scene, time: Array, n_cycles: int) -> Array:
    """Given times (n,) moved by whole periods into every cycle of the path of the actuators, cycle
    after cycle, (k,).

    Before them come those given times that lie in the initial loading, as they are; they are moved
    into the cycles, too.
    A path that does not repeat gets its times back. `n_cycles` is the number of cycles.
    """
    path = scene.load.path_of_actuators()
    if path.period is None:
        return time
    time_since_cycle_start = np.mod(time - path.cycle_start, path.period)
    times_in_cycles = (
        path.cycle_start + time_since_cycle_start + path.period * np.arange(n_cycles)[:, None]
    )
    return np.concatenate([time[time < path.cycle_start], times_in_cycles.ravel()])


def _rows_of_answer(
    driven_path: DrivenPath, scene: Scene, steady_from: int | None
) -> tuple[slice, PathRows]:
    """Rows, the ends of load steps, that the answer to a rig covers, as a slice. Second: P and Q at
    all rows of the path up to the last of these.

    Covered is the first steady cycle, with the row at which it begins; the whole path where no
    cycle is steady.

    Parameters
    ----------
    driven_path
        path with P and Q; `end_rows` are the rows at which the initial loading and each cycle end
    scene
        the scene, with the path of its actuators
    steady_from
        index of the first steady cycle, None without one
    """
    period = scene.load.path_of_actuators().period
    followed_path = driven_path.followed_path
    first_row = 0
    last_row = len(driven_path.time) - 1
    rows_at_ends: tuple[int, ...] = (last_row,)
    if steady_from is None:
        period = None
    else:
        # `end_rows` are the rows at which the initial loading ends, and each cycle.
        first_row = driven_path.end_rows[steady_from]
        last_row = driven_path.end_rows[steady_from + 1]
        rows_at_ends = (first_row, last_row)
    loads_up_to_end = PathRows(
        driven_path.time[: last_row + 1],
        followed_path.normal_load[: last_row + 1],
        followed_path.tangential_load[: last_row + 1],
        rows_at_ends,
        period,
    )
    return slice(first_row, last_row + 1), loads_up_to_end


def _scene_of_loads(scene: Scene, path_rows: PathRows, last_cycle: slice) -> Scene:
    """The scene with the loads P and Q that were found, as a polygon, in the place of the
    prescribed displacements. `path_rows` are the loads up to the end of the cycle whose rows are
    `last_cycle`.
    """
    loads = np.stack([path_rows.normal_load, path_rows.tangential_load], axis=1)
    polygon_vertices = [(float(normal), float(tangential)) for normal, tangential in loads]
    # The first point is the unloaded state. A cycle comes back to its begin, so that its last point
    # is left out.
    initial_loading = tuple(polygon_vertices[1:])
    cycle: tuple[tuple[float, float], ...] = ()
    if path_rows.period is not None:
        initial_loading = tuple(polygon_vertices[1 : last_cycle.start + 1])
        cycle = tuple(polygon_vertices[last_cycle.start + 1 : -1])
    # A scene without the displacements of the rig.
    polygon_of_loads = PolygonLoad(
        initial_loading=initial_loading, cycle=cycle, times=tuple(path_rows.time.tolist())
    )
    return scene.vary(load=polygon_of_loads, rig=Rig(), cycles=1)


def _errors_of_steps(
    fine_path: DrivenPath, coarse_path: DrivenPath, steady_from: int | None
) -> dict[str, float]:
    """Relative errors of friction work and of Q by the length of the load steps: differences
    between a path by fine steps and one by steps twice as long.

    The difference of the work is divided by W of the steady cycle `steady_from`, or of the path
    where there is none; that of Q by the largest |Q|. Without work, or without Q, there is no such
    error.
    """
    errors = {}
    # Rows of the steady cycle; end_rows: rows at which the initial loading and each cycle end.
    fine_rows = slice(0, None)
    coarse_rows = slice(0, None)
    if steady_from is not None:
        fine_rows = slice(fine_path.end_rows[steady_from], fine_path.end_rows[steady_from + 1] + 1)
        coarse_rows = slice(
            coarse_path.end_rows[steady_from], coarse_path.end_rows[steady_from + 1] + 1
        )
    work_by_fine_steps = fine_path.work(fine_rows)
    if work_by_fine_steps > 0:
        errors["dissipation"] = abs(coarse_path.work(coarse_rows) / work_by_fine_steps - 1)
    load_by_fine_steps = fine_path.followed_path.tangential_load
    largest_tangential_load = float(np.max(np.abs(load_by_fine_steps)))
    if largest_tangential_load > 0:
        # At the instants that both paths have.
        _, rows_in_fine_path, rows_in_coarse_path = np.intersect1d(
            fine_path.time, coarse_path.time, return_indices=True
        )
        load_difference = (
            load_by_fine_steps[rows_in_fine_path]
            - coarse_path.followed_path.tangential_load[rows_in_coarse_path]
        )
        errors["tangential_load"] = float(np.max(np.abs(load_difference))) / largest_tangential_load
    return errors


def _message(steady_from: int | None, scene: Scene) -> str:
    """How the path ended, in a sentence: with a steady cycle, at its end, or without a steady one
    among the cycles that were followed.
    """
    if steady_from is not None:
        return f"cycle {steady_from + 1} ends in the state it started from"
    if scene.load.path_of_actuators().period is None:
        return "the path was followed to its end"
    return f"no steady cycle among the first {max(scene.cycles, 2)}: the whole path is answered"


# ---------------------------------------------------------------------------------------- the words
def _notes(followed_rig: _FollowedRig, cycle_energy: _Energy) -> Iterator[str]:
    """Sentences for the notes of the answer to a rig. They state where displacements are
    prescribed, which effects are left out, how much of the motion the spring takes, gross sliding
    and separation.

    `cycle_energy` has the relative errors by the name of the value, and what tilt and bulk strain
    of the bodies add to the friction work.
    """
    scene = followed_rig.rig.scene
    yield from neglected_coupling(scene.material)
    yield from _notes_of_place(followed_rig, cycle_energy.part_by_tilt_and_strain)
    yield from _notes_of_loads(followed_rig, cycle_energy.errors.get("tangential_load", 0.0))
    yield from notes_of_slides(scene, followed_rig.fine_path, followed_rig.last_cycle)
    if np.any(followed_rig.fine_path.followed_path.normal_load[1:] <= 0):
        yield "separation: the bodies part, and nothing is remembered after it"


def _notes_of_place(
    followed_rig: _FollowedRig, part_by_tilt_and_strain: TiltAndStrainPart
) -> Iterator[str]:
    """Sentences on where the displacements of a rig are prescribed: at a distance from the contact
    of half-planes, or at the bases of finite bodies.

    Those of finite bodies also state their effects, with what tilt and bulk strain add to the
    friction work.
    """
    rig = followed_rig.rig
    scene = rig.scene
    if scene.bodies.half_planes:
        _, length_unit, _ = scene.unit_words
        yield (
            "rig: the displacements are prescribed at half-planes, in the distance"
            f" {rig.effects.datum_length:.6g} {length_unit} from the contact; U and approach here"
            f" count from {scene.profile.datum_length:.6g} {length_unit}, as in every answer"
        )
        return
    yield (
        "rig: the displacements are prescribed at the bases of the bodies; corrected theory is"
        " implied"
    )
    if has_next_order(rig.effects):
        yield _note_of_next_order(rig, followed_rig.fine_path, followed_rig.last_cycle)
    half_width = float(rig.contact.half_width(followed_rig.largest_load))
    modulus = composite_modulus(scene.material)  # E*
    yield from notes_of_effects(
        rig.effects, half_width, modulus, part_by_tilt_and_strain, WORDS_UNDER_RIG
    )


def _notes_of_loads(followed_rig: _FollowedRig, relative_error_of_load: float) -> Iterator[str]:
    """Sentences on the loads of a rig: which part of the actuator's range the contact takes in the
    last cycle, and how uncertain Q is.

    The spring between actuator and contact takes the rest of the range. `relative_error_of_load`
    is the error of Q over its largest value.
    """
    driven_path = followed_rig.fine_path
    force_unit, length_unit, _ = followed_rig.rig.scene.unit_words
    # of the tangential spring between actuator and contact, 0 if the rig is stiff
    if followed_rig.rig.compliance.tangential_spring_compliance:
        actuator_range = float(np.ptp(driven_path.actuator_displacement[followed_rig.last_cycle]))
        contact_range = float(np.ptp(driven_path.displacement[followed_rig.last_cycle]))
        yield (
            f"rig: of the range {actuator_range:.6g} {length_unit} of the actuator the contact"
            f" takes {contact_range:.6g}, the spring the rest"
        )
    largest_tangential_load = float(np.max(np.abs(driven_path.followed_path.tangential_load)))
    yield (
        "rig: P and Q follow from the displacements, at constant P without an error of the steps;"
        f" here Q is uncertain by {relative_error_of_load * largest_tangential_load:.2g} of at"
        f" most {largest_tangential_load:.6g} {force_unit}/{length_unit}"
    )


def _note_of_next_order(rig: RiggedScene, driven_path: DrivenPath, last_cycle: slice) -> str:
    """A sentence on the terms in x^4 of the finite bodies' effects, the next order after the
    curvatures, x^2. It states whether the friction work has them, and how much they would change
    the largest pressure and the half-width.

    `driven_path` holds the loads that were found along the path of the `rig`, `last_cycle` its rows
    of the last cycle. The two changes are those at the largest P of the path, without Q.
    """
    reason_without_next_order = _reason_without_next_order(driven_path, last_cycle)
    inclusion = (
        f"left out: {reason_without_next_order}"
        if reason_without_next_order
        else "in the dissipation"
    )
    # Two rows: no load, and the largest P of the path.
    normal_load = np.array([0.0, np.max(driven_path.followed_path.normal_load)])
    without_tangential_load = 0 * normal_load
    any_friction = 1.0  # without Q nothing slips
    effects_without_next_order = without_next_order(rig.effects)

    # Largest pressure and half-width with the next order, then without it.
    peak_pressures = []
    half_widths = []
    for effects_taken in (rig.effects, effects_without_next_order):
        # `follow`: edges of contact and friction memory at both rows; PathSeries: half-widths and
        # PointFields: pressure that follow from them.
        followed_rows = follow(
            driven_path.followed_path.table,
            any_friction,
            normal_load,
            without_tangential_load,
            curvatures_of(effects_taken),
        )
        path_of_two_rows = PathSeries(followed_rows, rig.contact, rig.modulus, effects_taken)
        half_width = float(path_of_two_rows.half_width[1])
        # _SAMPLED_PLACES: 200.
        places = np.linspace(0.0, half_width, _SAMPLED_PLACES)
        peak_pressures.append(
            float(np.max(PointFields(path_of_two_rows, places).pressure(np.array([1]))))
        )
        half_widths.append(half_width)
    return (
        f"effects: the next order of the bodies, N_4, T_4, N_22 and T_22, is {inclusion}, and in"
        " no other value: of the largest pressure it would make"
        f" {100 * (peak_pressures[0] / peak_pressures[1] - 1):+.2g} %, of the largest half-width"
        f" {100 * (half_widths[0] / half_widths[1] - 1):+.2g} %"
    )


def notes_of_slides(scene: Scene, driven_path: DrivenPath, last_cycle: slice) -> Iterator[str]:
    """Sentences on gross sliding, when the bodies slide as a whole: how far, when and with what
    friction work in the last cycle, and when before it.

    For a path without cycles they are about all of the path.

    Parameters
    ----------
    scene
        the scene, whose units are named
    driven_path
        sliding distance and work of each step of the path
    last_cycle
        rows of the last cycle; of the whole path if there is no cycle
    """
    force_unit, length_unit, _ = scene.unit_words
    energy_unit = f"{force_unit}·{length_unit}/{length_unit}"
    span_text = "the last cycle" if last_cycle.start else "the path"
    # Intervals of gross sliding: begin, end, distance and friction work of each.
    slides = slides_of(driven_path, last_cycle)
    slides_before = (
        slides_of(driven_path, slice(0, last_cycle.start + 1)) if last_cycle.start else []
    )
    if not slides:
        yield f"gross sliding: none in {span_text}"
    else:
        slide_distance = sum(abs(slide.distance) for slide in slides)
        slide_work = sum(slide.work for slide in slides)
        # _MOST_SLIDES_NAMED: 4.
        slides_in_words = "; ".join(
            _slide_in_words(slide, length_unit) for slide in slides[:_MOST_SLIDES_NAMED]
        )
        rest_text = (
            f"; and {len(slides) - _MOST_SLIDES_NAMED} more"
            if len(slides) > _MOST_SLIDES_NAMED
            else ""
        )
        yield (
            f"gross sliding: in {span_text} the bodies slide as a whole by {slide_distance:.6g}"
            f" {length_unit}, which takes {slide_work:.6g} {energy_unit} of the dissipation:"
            f" {slides_in_words}{rest_text}"
        )
    if slides_before:
        slides_in_words = "; ".join(
            _slide_in_words(slide, length_unit) for slide in slides_before[:2]
        )
        yield f"gross sliding: before it {slides_in_words}"


def _slide_in_words(slide: _Slide, length_unit: str) -> str:
    """An interval of gross sliding in words: times, direction and distance."""
    direction = "forward" if slide.distance > 0 else "back"
    return (
        f"from time {slide.begin:.6g} to {slide.end:.6g} {direction} by {abs(slide.distance):.6g}"
        f" {length_unit}"
    )
