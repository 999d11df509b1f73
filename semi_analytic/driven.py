"""Displacement control: the loads P(t), Q(t) that follow from what the actuators of a rig do, on
the memory curve of corrected theory.

A rig prescribes the tangential displacement U_act of an actuator, and P or the approach d_act of
another. Between actuator and contact is a spring, k_s and k_n [load per length, per thickness],
infinite in a stiff rig::

    U_act = U(Q) + Q/k_s + slide,        d_act = approach(P) + P/k_n

U(Q) is that of `corrected`, of the state that a straight step to (P, Q) makes.

Uniqueness. With c the half-width that sticks at the end of the step and G(c) as in
`corrected_memory`::

    dU/dQ + 1/k_s = (A/pi) ln(2 L/c) + c_t + T c^2/2 - T^2 G(c) c^2/8 - R alpha_Q^2 P + 1/k_s

Where this is positive for all c up to the largest a, Q is the one root between -f P and f P. With
half-planes of a short datum L it is not, and the path is refused: U would fall while Q grows.

Exactness. A step in which P rests is as good as any number of steps. Where P varies, Q over P is
not straight for a given U: the error falls with the square of the step, and is measured by steps
that are twice as long.

Gross sliding. Where U(f P) + f P/k_s is less than U_act, Q = f P (-f P in the other direction), and
the rest of the way slides as a whole: it wears off f P times the slide. As long as it slides Q
follows f P, also where P falls. In separation nothing is remembered, and U_act is free: what it
moves while P = 0 rubs nowhere. Bodies touch again without shear.

The work of slip beside the slide is that of `corrected_memory`, step by step.

# notation: A = 2/E*, L datum length, f friction coefficient, c half-width of a punch, F, eta, G,
#           kn, kt, T as in `corrected_memory`
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from scenes import InputError, LoadPath, LoadSegment, NotFoundError
from scenes.array_types import Array
from scenes.segments import NORMAL_LOAD, TANGENTIAL_LOAD
from semi_analytic.corrected_memory import (
    UNLOADED_STATE,
    Curvatures,
    FollowedPath,
    FrictionMemory,
    MemoryState,
    MemoryStep,
    Pieces,
    PunchTable,
    Row,
    area_of_loop,
    path_of_steps,
)
from semi_analytic.profiles import SymmetricContact

# Of the largest f P: to which Q of a step is found. Round-off of the memory curve is 1e-11.
_FORCE_TOLERANCE_SHARE = 1e-13
# Newton's steps with a bracket: about five are taken; bisection alone would take 45.
_MOST_ITERATIONS = 200
# Edges of contact that are kept.
_CACHED_EDGES = 8
# Share of f P within which Q is at the limit of sliding.
_FORCE_SHARE_AT_LIMIT = 1e-9
# Share of a step within which sliding begins at one of its ends.
_STEP_SHARE_AT_END = 1e-9
# Steps of a path over its number of cycles, about.
_STEPS_A_CYCLE = 200
# Steps that are followed at most: each takes about half a millisecond.
_MOST_ROWS = 100_000
# Two instants of this share of the path are one.
_SAME_INSTANT_SHARE = 1e-12
# Half-widths at which dU/dQ is looked at.
_SAMPLED_HALF_WIDTHS = 400
_BISECTION_COUNT = 60
# Share of the values at the ends of a bracket within which a function is 0.
_RESIDUAL_OF_ROOT = 1e-14
# Share of a displacement that is round-off.
_ROUND_OFF_DISPLACEMENT_SHARE = 1e-12
# Share of the range of the approach by which it may fall: cubics of the table leave 1e-11, and a
# datum that is too short much more than this.
_APPROACH_ERROR_OF_TABLE = 1e-9
_MOST_WIDENINGS = 60


class Compliance(NamedTuple):
    """Compliances of contact, bodies and springs: what moves the actuator besides gross sliding.

    Attributes
    ----------
    unit_compliance
        A/pi [1 / stress]
    datum_length
        L [length]
    normal_body_compliance, tangential_body_compliance
        c_n, c_t of the bodies [1 / stress]
    normal_spring_compliance, tangential_spring_compliance
        1/k_n, 1/k_s of the rig [1 / stress]; 0 in a stiff rig
    curvatures
        that finite bodies add per load: N of the gap and T_P of the faces per P, N_Q of the gap and
        T of the faces per Q
    tilt_products
        R alpha_P alpha_Q and R alpha_Q^2 of a parabola: the moment of the pressure, which sits
        beside x = 0 by the tilt, moves the bodies along x by alpha_Q M = -tilt_products . (P^2, P
        Q)
    """

    unit_compliance: float
    datum_length: float
    normal_body_compliance: float = 0.0
    tangential_body_compliance: float = 0.0
    normal_spring_compliance: float = 0.0
    tangential_spring_compliance: float = 0.0
    curvatures: Curvatures = Curvatures()
    tilt_products: tuple[float, float] = (0.0, 0.0)

    def displacement_by_tilt(
        self, normal_load: Array | float, tangential_load: Array | float
    ) -> Array:
        """Displacement that the tilt of finite bodies adds to U under P and Q [length], of the
        shape of the loads; 0 unless the profile is a parabola.

        A tilt alpha = alpha_P P + alpha_Q Q moves the contact of a parabola of radius R to x = -R
        alpha. The moment of its pressure, -R alpha P, moves the bodies by alpha_Q times it.
        `tilt_products` are R alpha_P alpha_Q and R alpha_Q^2.

        # notation: U tangential displacement
        """
        product_of_normal_load, product_of_tangential_load = self.tilt_products
        normal_loads = np.asarray(normal_load)
        return np.asarray(
            -normal_loads
            * (
                product_of_normal_load * normal_loads
                + product_of_tangential_load * np.asarray(tangential_load)
            )
        )

    def actuator_compliance(self, half_width: Array | float, normal_load: Array | float) -> Array:
        """Compliance d(U + Q/k_s)/dQ of the actuator at constant P [1/stress], where c =
        `half_width` > 0 is the half-width of the stick zone.

            (A/pi) ln(2 L/c) + c_t + T c^2/2 - T^2 G(c) c^2/8 + 1/k_s - R alpha_Q^2 P,
            G(c) = (pi E*/4) c^2

        U is the displacement of contact and bodies, G the load of the flat punches of x^2/2 up to
        half-width c. T is the curvature of the faces per Q, c_t the compliance of the bodies, k_s
        the tangential spring, L the datum length, A = 2/E*. R alpha_Q^2 is `tilt_products[1]`: R is
        the radius of a parabola, alpha_Q the tilt per Q. The curvatures that unlike bodies add, of
        the gap per Q and of the faces per P, are left out.
        """
        # unit_compliance: A/pi; curvatures.tangential: T; tangential_body_compliance: c_t;
        # tangential_spring_compliance: 1/k_s.
        stick_half_width = np.asarray(half_width, dtype=float)
        squared_half_width = stick_half_width**2
        face_curvature = self.curvatures.tangential
        # G(c) = (pi E*/4) c^2 = c^2/(2 A/pi)
        parabola_load = squared_half_width / (2 * self.unit_compliance)
        half_plane_compliance = self.unit_compliance * np.log(
            2 * self.datum_length / stick_half_width
        )
        compliance_by_bodies = (
            self.tangential_body_compliance
            + face_curvature * squared_half_width / 2
            - face_curvature**2 * parabola_load * squared_half_width / 8
        )
        decrease_by_tilt = self.tilt_products[1] * np.asarray(normal_load)
        return np.asarray(
            half_plane_compliance
            + compliance_by_bodies
            + self.tangential_spring_compliance
            - decrease_by_tilt
        )

    def require_unique_force(self, largest_half_width: float, largest_load: float) -> None:
        """Raise InputError if the displacement that a rig prescribes does not determine Q: if U of
        the contact plus Q/k_s of the rig's spring falls, or rests, while Q grows.

        The derivative d(U + Q/k_s)/dQ is checked at 400 half-widths of the stick zone, evenly
        spaced up to `largest_half_width` [length], under the normal load `largest_load`.
        """
        stick_half_width = (
            largest_half_width * np.arange(1, _SAMPLED_HALF_WIDTHS + 1) / _SAMPLED_HALF_WIDTHS
        )
        # dU/dQ plus the compliance of the spring, at 400 half-widths.
        compliance_of_actuator = self.actuator_compliance(stick_half_width, largest_load)
        if np.all(compliance_of_actuator > 0):
            return
        worst_half_width = float(stick_half_width[np.argmin(compliance_of_actuator)])
        raise InputError(
            f"load.tangential_displacement: with the datum length {self.datum_length:.6g} and the"
            f" half-width {worst_half_width:.4g} that sticks U falls while Q grows, so that no Q"
            " follows from U: state a longer rig.datum_length, of some heights of the bodies, or"
            " the bodies themselves"
        )


# --------------------------------------------------------------------------------- rows of the path
class ActuatorRows(NamedTuple):
    """Instants of a path of actuators, with P or the normal approach, 0 where it is negative, and
    U_act there, (n,) each.

    `end_rows` are the indices of the instants at which the initial loading and each cycle end; of a
    path without cycles that of the last instant.
    """

    time: Array
    load_or_approach: Array
    displacement: Array
    end_rows: tuple[int, ...]


def actuator_rows(
    path: LoadPath,
    n_cycles: int,
    refinement: int = 1,
    extra_times: Array | None = None,
    *,
    one_step_at_constant_load: bool = False,
    steps_per_cycle: int = _STEPS_A_CYCLE,
) -> ActuatorRows:
    """Instants between which the motion of the actuators of a rig is taken as linear, with P or the
    normal approach and U_act there.

    They are turning points, ends of segments, instants of separation and touch, ends of equal steps
    between these, and `extra_times` within the path. P or approach is 0 where it is negative.

    Parameters
    ----------
    path
        of the actuators: P or the normal approach in the place of P, U_act in that of Q
    n_cycles
        number of cycles after the initial loading
    refinement
        factor on the number of equal steps
    extra_times
        (k,) more instants
    one_step_at_constant_load
        whether to take one step, which is exact, between two turning points if P is constant there
    steps_per_cycle
        this times the number of cycles is about the number of steps of the path, before the
        `refinement`: all intervals between turning points have equally many, one at least. The
        initial loading takes its share of them, so that a cycle may have fewer steps than this

    Raises
    ------
    InputError
        For more steps than can be followed.
    """
    # Times between which each actuator moves one way.
    turning_times = np.array(_turning_times_of_actuators(path, n_cycles))
    # cycles over which the steps are counted; a path without a period counts as one
    n_cycles_of_steps = max(n_cycles, 1) if path.period is not None else 1
    n_steps_per_interval = refinement * _steps_between(
        len(turning_times), steps_per_cycle * n_cycles_of_steps
    )
    _require_few_steps(n_steps_per_interval * len(turning_times))
    time = _times_of_steps(path, turning_times, n_steps_per_interval, one_step_at_constant_load)
    if extra_times is not None:
        is_in_path = (extra_times > turning_times[0]) & (extra_times < turning_times[-1])
        time = np.append(time, extra_times[is_in_path])
    time = np.unique(time)

    # Instants nearer than 1e-12 of the duration become one.
    duration = turning_times[-1] - turning_times[0]
    time = time[np.diff(time, prepend=-np.inf) > _SAME_INSTANT_SHARE * duration]

    load_or_approach, displacement = path.at(time)
    # period: duration of a cycle, None for a path that does not repeat.
    cycle_end_times = [turning_times[-1]]
    if path.period is not None:
        cycle_end_times = [path.cycle_start + cycle * path.period for cycle in range(n_cycles + 1)]
    end_rows = tuple(int(np.argmin(np.abs(time - cycle_end))) for cycle_end in cycle_end_times)
    return ActuatorRows(time, np.maximum(load_or_approach, 0.0), displacement, end_rows)


def _steps_between(n_turning_times: int, n_steps_of_path: int) -> int:
    """Number of equal steps between two turning times of a path, at least one, so that the path has
    about `n_steps_of_path` in all.
    """
    return max(math.ceil(n_steps_of_path / n_turning_times), 1)


def _require_few_steps(n_steps: int) -> None:
    """InputError where a path of actuators takes more than 100,000 steps."""
    if n_steps > _MOST_ROWS:
        raise InputError(
            "load: the path of the actuators takes"
            f" {n_steps:,} steps and"
            f" {_MOST_ROWS:,} are followed at most: take a part of it, or fewer cycles"
        )


def _times_of_steps(
    actuator_path: LoadPath,
    turning_times: Array,
    n_steps_per_interval: int,
    one_step_at_constant_load: bool,
) -> Array:
    """Begins of the steps of a path of actuators, then the last turning time, (n,); ascending, some
    may be equal.

    There are `n_steps_per_interval` equal steps between each two of the ascending turning times.

    With `one_step_at_constant_load` there is one step, which is exact, between two of them if the
    normal actuator rests there: its begin is then repeated.
    """
    # (turning times - 1, steps between two of them)
    fractions = np.arange(n_steps_per_interval) / n_steps_per_interval
    step_times = turning_times[:-1, None] + np.diff(turning_times)[:, None] * fractions
    if one_step_at_constant_load:
        middle_times = (turning_times[1:] + turning_times[:-1]) / 2
        sample_times = np.array([turning_times[:-1], turning_times[1:], middle_times])
        loads_at_samples = actuator_path.at(sample_times)[0]
        largest_load = np.max(np.abs(loads_at_samples))
        # _SAME_INSTANT_SHARE: 1e-12.
        is_constant = np.ptp(loads_at_samples, axis=0) <= _SAME_INSTANT_SHARE * largest_load
        step_times[is_constant] = step_times[is_constant, :1]
    return np.append(step_times.ravel(), turning_times[-1])


def _turning_times_of_actuators(actuator_path: LoadPath, n_cycles: int) -> list[float]:
    """Ascending times between which the motion of each actuator of a rig is monotonic: turning
    points, ends of segments of the path, and instants at which the bodies separate or touch.

    `actuator_path` has the normal actuator in the place of P, the tangential one in that of Q; it
    is followed over the initial loading and the first `n_cycles` cycles.
    """
    segments = list(actuator_path.segments(n_cycles))
    # Segments of the initial loading and of each cycle, in order of time. NORMAL_LOAD: the normal
    # actuator, TANGENTIAL_LOAD: the tangential one.
    turning_times = [segments[0].start]
    for segment in segments:
        # ends of the parts of the segment on which both actuators move one way
        normal_turning_times = segment.turning_points(NORMAL_LOAD)
        tangential_turning_times = segment.turning_points(TANGENTIAL_LOAD)
        monotonic_ends = sorted(
            {segment.start, segment.end, *normal_turning_times, *tangential_turning_times}
        )
        # P, or the approach, changes its sign between two such times.
        touch_times = [
            _root_between(partial(_load_or_approach_at, segment), begin, end)
            for begin, end in pairwise(monotonic_ends)
            if segment.loads(begin)[0] * segment.loads(end)[0] < 0
        ]
        turning_times += sorted({*monotonic_ends[1:], *touch_times})
    return turning_times


def _load_or_approach_at(segment: LoadSegment, time: float) -> float:
    """P, or the normal approach of an actuator, at a time of a segment of its path."""
    return float(segment.loads(time)[0])


def _root_between(function: Callable[[float], float], begin: float, end: float) -> float:
    """Root of a function that has opposite signs at `begin` and `end`, by the Illinois algorithm.

    That is false position, but the value at an end that stays twice is halved. The iteration ends
    where the function is at most 1e-14 of the larger of its values at `begin` and `end`, or after
    200 trials.
    """
    value_at_begin = function(begin)
    value_at_end = function(end)
    largest_value = max(abs(value_at_begin), abs(value_at_end))
    root = begin
    moved_end = 0  # which end moved last: -1 the lower, 1 the upper
    for _ in range(_MOST_ITERATIONS):
        root = (begin * value_at_end - end * value_at_begin) / (value_at_end - value_at_begin)
        value_at_root = function(root)
        if abs(value_at_root) <= _RESIDUAL_OF_ROOT * largest_value:
            break
        if (value_at_root > 0) == (value_at_end > 0):
            end = root
            value_at_end = value_at_root
            value_at_begin = value_at_begin / 2 if moved_end == 1 else value_at_begin
            moved_end = 1
        else:
            begin = root
            value_at_begin = value_at_root
            value_at_end = value_at_end / 2 if moved_end == -1 else value_at_end
            moved_end = -1
    return root


def loads_of_approach(
    contact: SymmetricContact, modulus: float, compliance: Compliance, approach: Array
) -> Array:
    """Normal loads P (n,) [force per thickness] under given normal approaches of an actuator (n,)
    [length]; 0 where the approach is not positive, since the bodies are apart.

    Each contact half-width a has one load, P = eta(a)/(1 - N G(a)), and one approach, which grows
    with a: a is found by bisection of the approach. eta(a) is the load that presses the profile
    into half-planes up to a, and G(a) the load that presses a parabola x^2/2 into them up to a.

    Finite bodies add (N P + N_Q Q) x^2/2 to the gap, and (T Q + T_P P) x^2/2 to the tangential
    displacement of the faces. N_Q and T_P must be 0, as of bodies that are mirrored at x = 0, so
    that P does not depend on Q.

    Parameters
    ----------
    contact
        normal contact of the profile: load by half-width on half-planes
    modulus
        E* [stress]
    compliance
        of bodies and springs, with `curvatures` N, T, N_Q, T_P of the bodies
        [1/(stress length^2)]
    approach
        (n,) normal approaches of the actuator, positive where the bodies are pressed together

    Raises
    ------
    InputError
        For an approach that is never positive, goes beyond the profile, or falls while P grows; for
        bodies that are not mirrored at x = 0.
    """
    curvatures = compliance.curvatures
    # normal_under_shear: N_Q, tangential_under_pressure: T_P.
    if curvatures.normal_under_shear or curvatures.tangential_under_pressure:
        raise InputError(
            "load.approach: it is followed for bodies that are mirrored at x = 0, and N_Q or T_P of"
            " these are not 0: state the normal load"
        )
    largest_approach = float(np.max(approach))
    if not largest_approach > 0:
        raise InputError(
            "load.approach: it is never positive, so that the bodies never touch: an approach is"
            " positive where the bodies are pressed together"
        )

    # eta and G over a coordinate s, which is 0 at a = 0 and grows with a. The table ends at a
    # half-width with at least the largest approach.
    table = _table_of_approach(contact, modulus, compliance, largest_approach)

    # Bisection of s of the edge of contact, from 0 to the end of the table, for each approach.
    low_s = np.zeros(len(approach))
    high_s = np.full(len(approach), table.largest_s)
    for _ in range(_BISECTION_COUNT):
        middle_s = (low_s + high_s) / 2
        _, approach_at_middle = _load_and_approach(table, compliance, middle_s)
        is_too_low = approach_at_middle <= approach
        low_s = np.where(is_too_low, middle_s, low_s)
        high_s = np.where(is_too_low, high_s, middle_s)
    load, _ = _load_and_approach(table, compliance, (low_s + high_s) / 2)
    return np.where(approach > 0, load, 0.0)


def _load_and_approach(
    table: PunchTable, compliance: Compliance, edge_s: Array
) -> tuple[Array, Array]:
    """Normal load P [force per thickness] and normal approach of the actuator [length] for given
    edges of contact a, (n,) each.

        P = eta(a)/(1 - N G(a))
        approach = (A/pi) int ln(2 L/c) dP(c) + N p_2/2 + c_n P + P/k_n

    eta and G are the loads that press the profile and x^2/2 into contact up to a half-width. P(c)
    is what the flat punches up to c carry of P, p_2 the second moment of the pressure. N P x^2/2 is
    what the bodies add to the gap, c_n their compliance, k_n the spring, L the datum length, A =
    2/E*.

    Parameters
    ----------
    table
        loads and integrals of the flat punches by the coordinate s of their half-width c
    compliance
        A/pi as `unit_compliance`, datum length L, c_n, 1/k_n, and the curvature N
    edge_s
        (n,) coordinates of the edges of contact
    """
    # N; punch_sums: integrals of ln(2 L/c) and of c^2/2 over the punches up to the edge, each over
    # d eta and over dG.
    normal_curvature = compliance.curvatures.normal
    normal_load = table.profile_load(edge_s) / (1 - normal_curvature * table.parabola_load(edge_s))
    punch_sums = [table.punch_sums_at(s, compliance.datum_length) for s in edge_s.tolist()]
    logarithm_integral, parabola_logarithm, profile_second_moment, parabola_second_moment = (
        np.array(punch_sums).T
    )
    gap_curvature = normal_curvature * normal_load
    pressure_moment = profile_second_moment + gap_curvature * parabola_second_moment
    approach_of_half_planes = compliance.unit_compliance * (
        logarithm_integral + gap_curvature * parabola_logarithm
    )
    approach_of_load = (
        compliance.normal_body_compliance + compliance.normal_spring_compliance
    ) * normal_load
    normal_approach = (
        approach_of_half_planes + approach_of_load + normal_curvature * pressure_moment / 2
    )
    return normal_load, normal_approach


def _table_of_approach(
    contact: SymmetricContact, modulus: float, compliance: Compliance, largest_approach: float
) -> PunchTable:
    """Table of the flat punches of a contact up to a half-width at which the normal approach of the
    actuator is at least `largest_approach` [length].

    Parameters
    ----------
    contact
        normal contact of the profile
    modulus
        E* [stress]
    compliance
        compliances of half-planes, bodies and springs, with the datum length

    Raises
    ------
    InputError
        For an approach that needs a contact wider than the profile, or wider than the widest that
        was tried; if the approach falls while P grows.
    """
    profile_half_width = contact.extent  # half-width to which the profile is given
    # The table is widened by half, at most 60 times, until its end has the largest approach.
    # least_half_width: of the flat part of the profile.
    half_width = min(
        max(contact.least_half_width, 1e-6 * compliance.datum_length) * 1.01, profile_half_width
    )
    for _ in range(_MOST_WIDENINGS):
        punch_table = PunchTable(contact, modulus, half_width)
        _, approach_at_end = _load_and_approach(
            punch_table, compliance, np.array([punch_table.largest_s])
        )
        if approach_at_end[0] >= largest_approach:
            break
        if half_width >= profile_half_width:
            raise InputError(
                f"load.approach: {largest_approach:.6g} makes the contact wider than the profile,"
                f" {profile_half_width:.6g}: state a wider profile or a smaller approach"
            )
        half_width = min(half_width * 1.5, profile_half_width)
    else:
        raise InputError(
            f"load.approach: {largest_approach:.6g} is more than the profile can be pressed in:"
            " check units"
        )

    # The approach must grow with the half-width, and so with P: looked at in 10,241 half-widths.
    s = np.linspace(0.0, punch_table.largest_s, 20 * 512 + 1)
    _, sampled_approach = _load_and_approach(punch_table, compliance, s)
    largest_fall = float(np.max(np.maximum.accumulate(sampled_approach) - sampled_approach))
    # _APPROACH_ERROR_OF_TABLE: 1e-9 of the range of the approach.
    if largest_fall > _APPROACH_ERROR_OF_TABLE * np.ptp(sampled_approach):
        raise InputError(
            f"load.approach: with the datum length {compliance.datum_length:.6g} the approach falls"
            " while P grows, so that no P follows from it: state a longer rig.datum_length, of some"
            " heights of the bodies, or the bodies themselves"
        )
    return punch_table


# ------------------------------------------------------------------------------------ step by step
@dataclass(frozen=True, eq=False)
class DrivenPath:
    """Loads and gross sliding under the prescribed motion of the actuators of a rig.

    Attributes
    ----------
    time
        (n,) instants: those of the rows, and of the begin of each slide
    followed_path
        the memory curve under P(t) and Q(t), which are in it
    compliance
        of contact and rig
    slide_distance
        (n,) way that the contact slides as a whole in the step that ends at the row, positive of
        the upper body over the lower one along +x [length]
    rigid_displacement
        (n,) sum of all slides and of the way while the bodies were apart: U of the contact is U(Q)
        plus this [length]
    actuator_displacement
        (n,) U_act [length]
    end_rows
        rows at which the initial loading ends, and each cycle
    """

    time: Array
    followed_path: FollowedPath
    compliance: Compliance
    slide_distance: Array
    rigid_displacement: Array
    actuator_displacement: Array
    end_rows: tuple[int, ...]

    @property
    def displacement(self) -> Array:
        """U of the contact and the bodies, without the spring, (n,) [length]."""
        spring_compliance = self.compliance.tangential_spring_compliance
        return np.asarray(
            self.actuator_displacement - spring_compliance * self.followed_path.tangential_load
        )

    @cached_property
    def slide_work(self) -> Array:
        """f P times the slide of the step that ends at each row, (n,) [energy / thickness]."""
        load = self.followed_path.normal_load
        mean_load = (load + np.concatenate([load[:1], load[:-1]])) / 2
        return np.asarray(self.followed_path.friction * mean_load * np.abs(self.slide_distance))

    @cached_property
    def slip_work(self) -> Array:
        """Friction work of partial slip of the same steps, (n,) [energy / thickness]."""
        return self.compliance.unit_compliance * self.followed_path.step_work

    def work(self, cycle_rows: slice) -> float:
        """Friction work of partial slip and of sliding in a cycle or the path [energy per
        thickness]. The first of its rows ends the step before it, which does not count.
        """
        return float(np.sum((self.slip_work + self.slide_work)[cycle_rows][1:]))

    @cached_property
    def first_steady_cycle(self) -> int | None:
        """Index, from 0, of the first cycle that ends in the friction state it started from; None
        where none does.
        """
        return self.followed_path.first_steady_cycle(self.end_rows)

    def loop_work(self, cycle_rows: slice) -> float:
        """Closed integral of Q dU by straight steps, for the rows of a cycle: the second way to the
        work at constant P [energy per thickness].
        """
        return area_of_loop(
            self.followed_path.tangential_load[cycle_rows], self.displacement[cycle_rows]
        )


def follow_actuator(
    table: PunchTable,
    friction: float,
    compliance: Compliance,
    rows: ActuatorRows,
) -> DrivenPath:
    """Tangential load Q(t), partial slip and gross sliding of a contact in a rig, step by step from
    the unloaded state. The rig prescribes P and the displacement U_act(t) of an actuator.

    Parameters
    ----------
    table
        flat punches of the contact
    friction
        f
    compliance
        compliance of contact, bodies and springs
    rows
        instants with P as `load_or_approach` and U_act as `displacement`; `end_rows` are those at
        which the initial loading and each cycle end

    Examples
    --------
    >>> import numpy as np
    >>> from semi_analytic.hertz import HertzContact
    >>> contact = HertzContact(modulus=4 / np.pi, radius=1.0, datum_length=50.0)  # a^2 = P
    >>> table = PunchTable(contact, contact.modulus, largest_half_width=1.2)
    >>> rows = ActuatorRows(
    ...     time=np.array([0.0, 1.0, 2.0, 3.0]),
    ...     load_or_approach=np.array([0.0, 1.0, 1.0, 0.5]),
    ...     displacement=np.array([0.0, 0.0, 10.0, 10.0]),
    ...     end_rows=(3,),
    ... )
    >>> driven_path = follow_actuator(
    ...     table, 0.4, Compliance(unit_compliance=0.5, datum_length=50.0), rows
    ... )
    >>> force = driven_path.followed_path.tangential_load
    >>> force.tolist()  # unloaded, pressed, at the begin of the slide, sliding
    [0.0, 0.0, 0.4, 0.4, 0.2]
    >>> bool(driven_path.slide_distance[-1] > 0)  # P falls at constant U_act: the bodies slide on
    True
    """
    largest_load = float(np.max(rows.load_or_approach))
    # Memory of friction of the contact, of no memory curve yet, and the solver of Q in each step.
    memory = FrictionMemory(table, friction, largest_load, Pieces())
    step_solver = _StepSolver(memory, compliance)
    # The first instant is unloaded: P = Q = 0. `unloaded_contact`: loads, curvatures, edge.
    unloaded_contact = step_solver.contact_under_loads(0.0, 0.0)
    growing_path = _GrowingPath(
        _Instant(float(rows.time[0]), 0.0, 0.0, float(rows.displacement[0])),
        _SolvedStep(unloaded_contact, memory.step(UNLOADED_STATE, unloaded_contact)),
    )
    # where each instant of `rows` is in the path: begins of slides are in it too
    index_of_row = [0] * len(rows.time)
    for row_number in range(1, len(rows.time)):
        instant_after = _Instant(
            time=float(rows.time[row_number]),
            normal_load=float(rows.load_or_approach[row_number]),
            tangential_load=0.0,  # not known yet
            actuator_displacement=float(rows.displacement[row_number]),
        )
        # A step is split where gross sliding begins within it.
        for part_end in step_solver.ends_of_parts(
            growing_path.last_instant, instant_after, growing_path.free_displacement
        ):
            solved_step = step_solver.solved_step(
                growing_path.last_state,
                part_end,
                growing_path.last_instant.tangential_load,
                growing_path.free_displacement,
            )
            growing_path.add(part_end, solved_step)
        index_of_row[row_number] = len(growing_path.steps) - 1
    return growing_path.driven_path(
        memory, compliance, tuple(index_of_row[row] for row in rows.end_rows)
    )


class _GrowingPath:
    """The path of a rig so far: its instants, and the solved step that ends at each.

    Attributes
    ----------
    last_instant
        the instant that was added last, with its Q
    free_displacement
        part of U_act by gross sliding and separation so far, which causes no Q [length]; U_act is
        the displacement of the actuator
    steps
        the solved steps
    """

    def __init__(self, first_instant: _Instant, first_step: _SolvedStep) -> None:
        """A path of one unloaded instant; U_act counts from there."""
        self.last_instant = first_instant
        self.free_displacement = first_instant.actuator_displacement
        self.steps = [first_step]
        self._instants = [first_instant]
        self._free_displacements = [self.free_displacement]

    @property
    def last_state(self) -> MemoryState:
        """State of the friction memory at the last instant."""
        return self.steps[-1].memory_step.state

    def add(self, instant: _Instant, solved_step: _SolvedStep) -> None:
        """Add an instant, whose Q is that of the solved step that ends there."""
        self.free_displacement += solved_step.slide_distance + solved_step.distance_apart
        self.last_instant = instant._replace(tangential_load=solved_step.contact.tangential_load)
        self.steps.append(solved_step)
        self._instants.append(self.last_instant)
        self._free_displacements.append(self.free_displacement)

    def driven_path(
        self, memory: FrictionMemory, compliance: Compliance, end_rows: tuple[int, ...]
    ) -> DrivenPath:
        """The path as arrays over its instants.

        `memory` is the friction memory of the contact with all its pieces of memory curve.
        `end_rows` are the numbers of the instants at which the initial loading and each cycle end.
        A memory curve is the tangential force that stuck punches keep.
        """
        # Loads, curvatures and edge of contact: one line of the array for each field of `Row`.
        memory_rows = np.array([solved_step.contact for solved_step in self.steps]).T
        memory_steps = [solved_step.memory_step for solved_step in self.steps]
        return DrivenPath(
            time=np.array([instant.time for instant in self._instants]),
            followed_path=path_of_steps(memory, memory_rows, memory_steps),
            compliance=compliance,
            slide_distance=np.array([solved_step.slide_distance for solved_step in self.steps]),
            rigid_displacement=np.array(self._free_displacements),
            actuator_displacement=np.array(
                [instant.actuator_displacement for instant in self._instants]
            ),
            end_rows=end_rows,
        )


class _Instant(NamedTuple):
    """Time, P, Q, U_act = `actuator_displacement`."""

    time: float
    normal_load: float
    tangential_load: float
    actuator_displacement: float

    def at_fraction(self, end: _Instant, fraction: float) -> _Instant:
        """The instant at a fraction, 0 to 1, of the straight step from this one to `end`: time, P
        and U_act are interpolated; Q is not known yet and stated as 0.
        """
        return _Instant(
            self.time + fraction * (end.time - self.time),
            self.normal_load + fraction * (end.normal_load - self.normal_load),
            0.0,
            self.actuator_displacement
            + fraction * (end.actuator_displacement - self.actuator_displacement),
        )


class _SolvedStep(NamedTuple):
    """A step of the rig of which Q is known.

    Attributes
    ----------
    contact
        P, Q, curvatures and edge of contact at its end
    memory_step
        memory of friction and slip zones at its end
    slide_distance
        way of gross sliding in the step [length]
    distance_apart
        way of the actuator while the bodies are apart [length]
    """

    contact: Row
    memory_step: MemoryStep
    slide_distance: float = 0.0
    distance_apart: float = 0.0


class _Trial(NamedTuple):
    """A step that was tried with some Q.

    Attributes
    ----------
    tangential_load
        Q at its end [force per thickness]
    memory_step
        memory of friction and slip zones at its end
    displacement_without_slide
        U + Q/k_s there [length]: U of the contact and the bodies, k_s the spring of the rig. It is
        the displacement of the actuator but for gross sliding and separation
    """

    tangential_load: float
    memory_step: MemoryStep
    displacement_without_slide: float


class _StepSolver:
    """Solves the steps of a rig one after another: Q from U_act."""

    def __init__(self, memory: FrictionMemory, compliance: Compliance) -> None:
        """Prepare the steps of a rig: a cache of edges of contact, and the integrals over the
        pieces of memory curve so far, of which there is the empty curve only.

        Parameters
        ----------
        memory
            memory of friction of the contact, with its table of flat punches
        compliance
            compliance of contact, bodies and springs, with the datum length
        """
        self._memory = memory
        self._compliance = compliance
        self._table = memory.table
        # Trials of a step have one P. Where the gap has no curvature per Q, N_Q = 0, they have one
        # edge of contact, too.
        # _CACHED_EDGES: 8.
        self._cached_edge_s = lru_cache(maxsize=_CACHED_EDGES)(memory.table.edge_s_of_load)
        # Of each piece of memory curve, by its number, integrals up to its top. First those over
        # the loads eta and G of the punches; then int ln(2 L/c) dF and int (c^2/2) dF, F the
        # locked-in tangential force. Number 0 is the empty curve.
        self._sums_at_tops = [self._table.punch_sums_at(0.0, compliance.datum_length)]
        self._logarithm_integrals_at_tops = [0.0]
        self._second_moments_at_tops = [0.0]

    def contact_under_loads(self, normal_load: float, tangential_load: float) -> Row:
        """Loads P and Q, the curvatures that they add to gap and faces, and the edge of contact
        under them. With it are the loads of the flat punches up to that edge.
        """
        # N, N_Q of the gap per P and per Q; T, T_P of the faces per Q and per P.
        curvatures = self._compliance.curvatures
        gap_curvature = (
            curvatures.normal * normal_load + curvatures.normal_under_shear * tangential_load
        )
        face_curvature = (
            curvatures.tangential * tangential_load
            + curvatures.tangential_under_pressure * normal_load
        )
        # Coordinate s of the edge of contact in the table of punches; then the loads of the punches
        # up to it: of the profile, of x^2/2 and of x^4/24.
        edge_s = self._edge_s(normal_load, gap_curvature)
        edge_loads = self._table.punch_loads_at(edge_s)
        return Row(
            normal_load=normal_load,
            tangential_load=tangential_load,
            normal_curvature=gap_curvature,
            tangential_curvature=face_curvature,
            normal_fourth=0.0,
            tangential_fourth=0.0,
            edge_s=edge_s,
            edge_load=edge_loads.profile_load,
            edge_parabola_load=edge_loads.parabola_load,
            edge_fourth_load=edge_loads.fourth_load,
        )

    def ends_of_parts(
        self, begin: _Instant, end: _Instant, free_displacement: float
    ) -> tuple[_Instant, ...]:
        """Instants at which to solve the step from `begin` to `end`: the begin of gross sliding if
        that is in between, and `end`.

        Sliding begins when U_act, the displacement of the actuator, minus that by earlier sliding
        and separation (`free_displacement` [length]), exceeds U + Q/k_s at Q = +-f P: U of the
        contact and the bodies, Q/k_s the extension of the rig's spring. The memory of friction is
        as before when this returns.
        """
        memory = self._memory
        # is_unloaded: P is 0 but for round-off, the bodies are apart.
        if memory.is_unloaded(end.normal_load) or memory.is_unloaded(begin.normal_load):
            return (end,)

        # Pieces of memory curve before the trials, which are discarded after each.
        n_pieces = len(memory.pieces)

        def excess_displacement(direction: int, fraction_of_step: float) -> float:
            """How far U_act, counted along a direction +1 or -1, is beyond that at the limit of
            sliding, at a fraction of the step [length].
            """
            trial_instant = begin.at_fraction(end, fraction_of_step)
            contact_at_limit = self.contact_under_loads(
                trial_instant.normal_load, direction * memory.friction * trial_instant.normal_load
            )
            displacement_at_limit = self._displacement_without_slide(
                contact_at_limit, memory.step_of_gross_sliding(contact_at_limit, direction)
            )
            self._discard_pieces(n_pieces)  # of this trial
            return direction * (
                trial_instant.actuator_displacement - free_displacement - displacement_at_limit
            )

        for direction in (1, -1):
            friction_limit = memory.friction * begin.normal_load
            # _FORCE_SHARE_AT_LIMIT: 1e-9 of f P.
            slides_already = direction * begin.tangential_load >= friction_limit * (
                1 - _FORCE_SHARE_AT_LIMIT
            )
            if (
                slides_already
                or excess_displacement(direction, 1.0) <= 0
                or excess_displacement(direction, 0.0) >= 0
            ):
                continue
            # Fraction of the step at which sliding begins, unless it is at one of its ends.
            fraction_of_step = _root_between(partial(excess_displacement, direction), 0.0, 1.0)
            # _STEP_SHARE_AT_END: 1e-9 of the step.
            if _STEP_SHARE_AT_END < fraction_of_step < 1 - _STEP_SHARE_AT_END:
                return begin.at_fraction(end, fraction_of_step), end
        return (end,)

    def solved_step(
        self,
        state: MemoryState,
        end: _Instant,
        tangential_load_before: float,
        free_displacement: float,
    ) -> _SolvedStep:
        """Tangential load Q at the instant `end` of a rig, with the memory of friction and gross
        sliding there.

        Q is the root of U(Q) + Q/k_s = U_act - `free_displacement` by Newton's method in a bracket:
        U of the contact and the bodies, k_s the spring of the rig, U_act of the actuator.
        If |Q| would exceed f P, the bodies slide as a whole; if P is 0, they are apart.

        Parameters
        ----------
        state
            memory of friction at the begin of the step
        tangential_load_before
            Q at the begin of the step
        free_displacement
            part of U_act by earlier sliding and separation [length]

        Raises
        ------
        NotFoundError
            If no Q is found.
        """
        memory = self._memory
        if memory.is_unloaded(end.normal_load):
            # The bodies are apart: the actuator moves freely.
            open_contact = self.contact_under_loads(0.0, 0.0)
            return _SolvedStep(
                open_contact,
                memory.step(state, open_contact),
                distance_apart=end.actuator_displacement - free_displacement,
            )
        target_displacement = end.actuator_displacement - free_displacement
        friction_limit = memory.friction * end.normal_load

        # Trial with the Q before: the actuator must push forward or back from there.
        # Each trial adds pieces of memory curve, which are discarded after it.
        n_pieces = len(memory.pieces)
        tangential_load = min(max(tangential_load_before, -friction_limit), friction_limit)
        trial = self._trial(state, end.normal_load, tangential_load)
        self._discard_pieces(n_pieces)
        # The slide is in the direction of the push, if there is one.
        direction = 1 if trial.displacement_without_slide <= target_displacement else -1

        # Sliding as a whole, if U_act goes beyond U + Q/k_s at Q = +-f P.
        contact_at_limit = self.contact_under_loads(end.normal_load, direction * friction_limit)
        sliding_step = memory.step_of_gross_sliding(contact_at_limit, direction)
        slide_distance = target_displacement - self._displacement_without_slide(
            contact_at_limit, sliding_step
        )

        # At the begin of a slide `slide_distance` is round-off, of either sign.
        # _ROUND_OFF_DISPLACEMENT_SHARE: 1e-12 of the displacement.
        if direction * slide_distance >= -_ROUND_OFF_DISPLACEMENT_SHARE * abs(target_displacement):
            return _SolvedStep(contact_at_limit, sliding_step, slide_distance=slide_distance)
        self._discard_pieces(n_pieces)
        return self._step_by_newton(
            state, end, trial, target_displacement, direction * friction_limit
        )

    def _step_by_newton(
        self,
        state: MemoryState,
        end: _Instant,
        first_trial: _Trial,
        target_displacement: float,
        limit_force: float,
    ) -> _SolvedStep:
        """A step in partial slip to the instant `end`: the Q at which the actuator has moved as far
        as the rig prescribes, by Newton's method within a bracket.

        The actuator moves by U + Q/k_s: U of contact and bodies, and the spring k_s of the rig.
        Without a slide this is `displacement_without_slide` of a trial, a step with a trial value
        of Q. The memory curve is the tangential force of the flat punches up to each half-width;
        it is made of pieces. `self._memory` holds the pieces of all steps so far, and f.

        Parameters
        ----------
        state
            what the contact remembers at the begin of the step: the uppermost piece of its memory
            curve, and the last direction of slip
        end
            instant at the end of the step, with its P
        first_trial, limit_force
            trial whose Q is one bound of the bracket; the other bound, +f P or -f P
        target_displacement
            U + Q/k_s that is wanted [length]

        Raises
        ------
        NotFoundError
            If no Q is found.
        """
        memory = self._memory
        # A trial adds pieces, which are discarded unless it is the last trial.
        # `trial.memory_step`: what is remembered at the end of a trial, and its slip zones.
        n_pieces = len(memory.pieces)
        trial = first_trial
        lower_tangential_load, upper_tangential_load = sorted((trial.tangential_load, limit_force))
        # _FORCE_TOLERANCE_SHARE: 1e-13 of f times the largest P of the path.
        load_tolerance = _FORCE_TOLERANCE_SHARE * memory.friction * memory.largest_load
        for _ in range(_MOST_ITERATIONS):
            missing_displacement = target_displacement - trial.displacement_without_slide
            new_tangential_load = (
                trial.tangential_load
                + missing_displacement / self._compliance_at(trial.memory_step, end.normal_load)
            )
            if not lower_tangential_load <= new_tangential_load <= upper_tangential_load:
                new_tangential_load = (lower_tangential_load + upper_tangential_load) / 2
            change_of_load = new_tangential_load - trial.tangential_load
            trial = self._trial(state, end.normal_load, new_tangential_load)
            if (
                abs(change_of_load) <= load_tolerance
                or trial.displacement_without_slide == target_displacement
            ):
                return _SolvedStep(
                    self.contact_under_loads(end.normal_load, new_tangential_load),
                    trial.memory_step,
                )
            self._discard_pieces(n_pieces)
            if trial.displacement_without_slide < target_displacement:
                lower_tangential_load = new_tangential_load
            else:
                upper_tangential_load = new_tangential_load
        raise NotFoundError(
            f"at time {end.time:.6g} no Q was found that moves the actuator by"
            f" {end.actuator_displacement:.6g}"
        )

    def _trial(self, state: MemoryState, normal_load: float, tangential_load: float) -> _Trial:
        """Trial of a step from `state` to the loads P and Q: memory of friction after it, and the
        displacement of the actuator there.

        The pieces of the new memory curve are stored.
        """
        contact_row = self.contact_under_loads(normal_load, tangential_load)
        memory_step = self._memory.step(state, contact_row)
        displacement = self._displacement_without_slide(contact_row, memory_step)
        return _Trial(tangential_load, memory_step, displacement)

    def _displacement_without_slide(self, contact_row: Row, memory_step: MemoryStep) -> float:
        """Displacement U + Q/k_s of the actuator at the end of a step [length]: U of contact and
        bodies, plus the extension of the spring k_s. Gross sliding and separation are not in it.
        `contact_row` has P, Q, curvatures and edge of contact there.

            (A/pi) int ln(2 L/c) dM + (c_t + 1/k_s) Q + T q_2/2 + N_Q p_2/2 + U_tilt

        U_tilt is what tilt adds for a parabola. M(c) is the tangential force that flat punches of
        half-width up to c carry. p_2 and q_2 are the second moments of pressure and shear traction.
        T and N_Q are curvatures of the bodies per Q, c_t is their compliance.

        # notation: F locked-in tangential force of the punches up to half-width c, kt curvature of
        #           the faces under the loads, eta and G loads that press the profile and x^2/2 into
        #           contact up to c, L datum length, A = 2/E*
        """
        self._integrate_new_pieces()
        compliance = self._compliance
        # Of `compliance`: unit_compliance is A/pi; curvatures.tangential is T, normal_under_shear
        # N_Q.
        curvatures = compliance.curvatures

        # Integrals of ln(2 L/c) and c^2/2 over the punches up to the edge, each over d eta and over
        # dG.
        sums_at_edge = self._table.punch_sums_at(contact_row.edge_s, compliance.datum_length)
        uppermost_piece = memory_step.state.uppermost_piece
        face_curvature = contact_row.tangential_curvature

        # dM = dF + kt dG: the integrals over F are stored with the pieces of the memory curve.
        logarithm_integral = (
            self._logarithm_integrals_at_tops[uppermost_piece]
            + face_curvature * sums_at_edge.parabola_logarithm
        )
        shear_second_moment = (
            self._second_moments_at_tops[uppermost_piece]
            + face_curvature * sums_at_edge.parabola_second_moment
        )
        pressure_second_moment = (
            sums_at_edge.second_moment
            + contact_row.normal_curvature * sums_at_edge.parabola_second_moment
        )
        actuator_displacement = compliance.unit_compliance * logarithm_integral

        # c_t and 1/k_s.
        added_compliance = (
            compliance.tangential_body_compliance + compliance.tangential_spring_compliance
        )
        actuator_displacement += added_compliance * contact_row.tangential_load
        actuator_displacement += curvatures.tangential * shear_second_moment / 2
        actuator_displacement += curvatures.normal_under_shear * pressure_second_moment / 2
        displacement_by_tilt = compliance.displacement_by_tilt(
            contact_row.normal_load, contact_row.tangential_load
        )
        return actuator_displacement + float(displacement_by_tilt)

    def _compliance_at(self, memory_step: MemoryStep, normal_load: float) -> float:
        """Compliance d(U + Q/k_s)/dQ of the actuator at the end of a step under P = `normal_load`
        [1/stress].

        It follows from the half-width that sticks there, at least 1e-9 of the table's largest. U is
        the displacement of contact and bodies, k_s the spring of the rig.
        """
        # Coordinates s in the table of punches: inner end of an inner slip zone, else the stick
        # edge.
        stick_edge_s = (
            memory_step.inner_zone_s[0]
            if memory_step.inner_zone_direction
            else memory_step.stick_edge_s
        )
        stick_half_width = float(self._table.half_width(stick_edge_s))
        least_half_width = 1e-9 * float(self._table.half_width(self._table.largest_s))
        return float(
            self._compliance.actuator_compliance(
                max(stick_half_width, least_half_width), normal_load
            )
        )

    def _edge_s(self, normal_load: float, gap_curvature: float) -> float:
        """s of the edge of contact under P = `normal_load`; 0 if the bodies are apart."""
        if self._memory.is_unloaded(normal_load):
            return 0.0
        return self._cached_edge_s(normal_load, gap_curvature)

    def _integrate_new_pieces(self) -> None:
        """Store the integrals of new pieces of memory curve that the displacement U and the second
        moment of the shear need: int ln(2 L/c) dF and int (c^2/2) dF up to the top of each.

        F(c) is the locked-in tangential force of the flat punches up to half-width c. On a piece dF
        = profile_slope d eta + parabola_slope dG, with eta and G the loads that press the profile
        and x^2/2 into contact up to c. L is the datum length.
        """
        # Three lists with one entry for each piece of memory curve; number_below: of the piece that
        # it continues; top_s: coordinate s of its outer end.
        pieces = self._memory.pieces
        for piece in pieces[len(self._sums_at_tops) :]:
            sums_at_top = self._table.punch_sums_at(piece.top_s, self._compliance.datum_length)
            sums_below = self._sums_at_tops[piece.number_below]
            # Of this piece alone.
            logarithm_integral_of_piece = piece.profile_slope * (
                sums_at_top.logarithm - sums_below.logarithm
            )
            logarithm_integral_of_piece += piece.parabola_slope * (
                sums_at_top.parabola_logarithm - sums_below.parabola_logarithm
            )
            second_moment_of_piece = piece.profile_slope * (
                sums_at_top.second_moment - sums_below.second_moment
            )
            second_moment_of_piece += piece.parabola_slope * (
                sums_at_top.parabola_second_moment - sums_below.parabola_second_moment
            )
            logarithm_integral_below = self._logarithm_integrals_at_tops[piece.number_below]
            second_moment_below = self._second_moments_at_tops[piece.number_below]
            self._sums_at_tops.append(sums_at_top)
            self._logarithm_integrals_at_tops.append(
                logarithm_integral_below + logarithm_integral_of_piece
            )
            self._second_moments_at_tops.append(second_moment_below + second_moment_of_piece)

    def _discard_pieces(self, n_pieces: int) -> None:
        """Keep the first `n_pieces` pieces of memory curve, with their integrals; those of a trial
        are removed.
        """
        self._memory.pieces.keep_first(n_pieces)
        del self._sums_at_tops[n_pieces:]
        del self._logarithm_integrals_at_tops[n_pieces:]
        del self._second_moments_at_tops[n_pieces:]
