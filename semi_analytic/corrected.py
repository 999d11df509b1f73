"""Corrected half-plane theory: the answer with what finite bodies add to the compliance of
half-planes, as `Findings`.

Effects of the bodies that are even in x are exact but for the straight steps of the load path:

- curvatures N, N_Q of the gap and T, T_P of the faces per P and Q, and those of the next order,
  N_4, T_4, N_22, T_22 (`corrected_memory`);
- compliances c_n and c_t.

With the moments p_k = int x^k p dx and q_k = int x^k q dx, and with half-planes whose datum is that
of the effects::

    approach = (A/pi) int ln(2 L/c) dP + c_n P + N p_2/2 + T_P q_2/2 + N_4 p_4/24
    U        = (A/pi) int ln(2 L/c) dM + c_t Q + T q_2/2 + N_Q p_2/2 + T_4 q_4/24

The fractions follow from reciprocity: a force at s moves x as a force at x moves s. What higher
orders may change is in the errors of dissipation, pressure and half-width (`next_order`).

Where a slip zone does not reach the edge, |q| of the memory curve exceeds f p by a share of second
order in the curvatures. Points slip further there until it does not (`inner_slip`). This extra slip
is in shear, slip and state, and in neither U nor W.

Tilt and bulk strain are odd in x: o = (alpha_P, alpha_Q, e_P, e_Q) P0/(a0/R). They change the
dissipation, pressure and half-widths of a symmetric profile in the second order of o, and move the
edges in the first. For a parabola (`odd_memory`) they are in the dissipation, in the edges of
contact and stick, and in the permanent stick half-width; in no field at points. A note states how
large they are, or why they are left out. Of unlike materials (Dundurs' beta) they count in the
first order.

A path is followed by straight steps, some 400 a cycle, with the bodies and with half-planes. W and
W(x) are those of exact half-plane theory plus the difference of the two paths. The difference of
the path of half-planes from exact theory gives the error of the steps.

# notation: A = 2/E*, a contact half-width, c half-width of a flat punch, eta normal load that the
#           profile's punches up to c carry, G that of a parabola's per curvature, G_4 of x^4/24
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    BodyEffects,
    Estimate,
    InputError,
    Scene,
)
from scenes.array_types import Array, Indices
from scenes.body_effects import ZERO_ESTIMATE
from scenes.errors import first_line
from semi_analytic.answer import (
    Findings,
    Question,
    StopWatch,
    is_between_edges,
    mirrored_points,
    neglected_coupling,
)
from semi_analytic.answer_by_memory import (
    distances_and_indices,
    findings_by_memory,
    path_of_question,
)
from semi_analytic.corrected_memory import (
    Curvatures,
    FollowedPath,
    PunchTable,
    area_of_loop,
    follow,
)
from semi_analytic.elasticity import composite_modulus
from semi_analytic.hertz import HertzContact
from semi_analytic.history import History, cycles_to_follow, histories_kept, time_in_followed_path
from semi_analytic.inner_slip import InnerSlip, SlipAtPoints, inner_slip
from semi_analytic.load_series import LoadSeries
from semi_analytic.next_order import (
    CURVATURES,
    LEAST_UNCERTAIN_FRACTION,
    has_next_order,
    ratio_of_next_order,
    uncertain_fraction_of_curvatures,
    uncertain_fraction_of_tilt_and_strain,
    with_one_group_alone,
)
from semi_analytic.odd_memory import (
    TILT_AND_STRAIN_NAMES,
    DeclinedError,
    SecondOrderAnswer,
    second_order_answer,
)
from semi_analytic.profiles import SymmetricContact, contact_of
from semi_analytic.tilt_and_strain import change_by_tilt_and_strain, work_of_half_planes

_FIELDS_OF_WORK = frozenset(("dissipation", "dissipation_density"))
# Instants that are followed at most: each takes some 30 us and two pieces of memory curve.
_MOST_ROWS = 200_000
# Half-width of the table of punches over that of the largest contact; and how often it is widened.
_TABLE_WIDTH_FACTOR = 1.02
_MOST_WIDENINGS = 60
# Punches at which the table is checked.
_PUNCHES_CHECKED = 200
# Two instants nearer than this fraction of the path's duration are one.
_SAME_INSTANT_SHARE = 1e-12
# Punches at whose turning points the path is cut, by their G over that of the largest.
_PARABOLA_FRACTIONS = np.linspace(0.0, 1.0, 6)
# Fraction of a step within which a turning point is at its end: a step as short would hold no slip.
_STEP_SHARE_AT_ROW = 0.02
# Of the error that the steps make of W of half-planes, what they leave in the change by the bodies:
# 0.14 at most on three ellipses with each of the curvatures, by steps that were ten times shorter.
_FACTOR_ON_STEP_ERROR = 0.5
# Of the change of W by steps that are halved, what is left: 1/3 falls with the square of a step.
_FACTOR_ON_HALVING = 2.0
# Fraction of the largest P up to which growth in stick is short: chords of 0.5 % of it leave 5e-8
# of W at most of six library scenes with the numbers of `blocks`.
_SHORT_CHORD_LOAD_SHARE = 0.01
# The largest relative change of the dissipation by tilt and bulk strain that is added, on grids.
_LARGEST_CHANGE_ON_GRIDS = 0.3
# Instants and places at which the error of the steps is measured, and the fraction of a half-width
# within which a point is at an edge.
_INSTANTS_COMPARED = 9
_PLACES_COMPARED = 36
_EDGE_DISTANCE_SHARE = 0.01
# Places at which |q| is compared with f p, and the fraction of the largest f p by which it is
# beyond: a third of what breaks a law of an answer by steps.
_PLACES_CHECKED_FIRST, _PLACES_CHECKED = 30, 100
_EXCESS_TOLERANCE_SHARE = 3e-7
# Instants of which this is done at once: 2 MB.
_ROWS_AT_ONCE = 2000


# ------------------------------------------------------------------------------------- the effects
def curvatures_of(effects: BodyEffects) -> Curvatures:
    """Curvatures that finite bodies add to gap and faces per unit of load, as plain numbers without
    their uncertainties.

    Second order [1/(stress length^2)]: N, N_Q of the gap per P and per Q, T, T_P of the tangential
    displacement of the faces per Q and per P. Fourth order [1/(stress length^4)]: N_4, T_4, the
    factors of x^4/24, and N_22, T_22, those of the mixed term x^2 s^2 of the kernel.

    Parameters
    ----------
    effects
        what the finite bodies add to the compliance of half-planes; each number is an `Estimate`,
        whose `value` is taken and whose `uncertainty` is left out
    """
    return Curvatures(
        normal=effects.normal_curvature.value,
        normal_under_shear=effects.normal_curvature_under_shear.value,
        tangential=effects.tangential_curvature.value,
        tangential_under_pressure=effects.tangential_curvature_under_pressure.value,
        normal_fourth=effects.normal_fourth.value,
        tangential_fourth=effects.tangential_fourth.value,
        normal_mixed=effects.normal_mixed.value,
        tangential_mixed=effects.tangential_mixed.value,
    )


def dimensionless_tilt_and_strain(
    effects: BodyEffects, half_width: float, modulus: float
) -> tuple[float, ...]:
    """Tilt alpha and bulk strain e of the bodies per P and per Q, made dimensionless: o = (alpha_P,
    alpha_Q, e_P, e_Q) P0/(a0/R).

    a0/R, the slope at the edge of a Hertzian contact, is taken for any profile as 4 P0/(pi E* a0).
    So P0 drops out, and the factor is pi E* a0/4.

    Parameters
    ----------
    effects
        what the finite bodies add to the compliance of half-planes, each number with its
        uncertainty
    half_width, modulus
        a0 [length] and E* [stress]

    # notation: P normal, Q tangential load, a0 contact half-width under the load P0, R radius of a
    #           parabola with that half-width
    """
    # P0/(a0/R)
    load_over_slope = math.pi * modulus * half_width / 4
    # TILT_AND_STRAIN_NAMES: attributes of `effects` with tilt under P and Q, strain under P and Q.
    return tuple(getattr(effects, name).value * load_over_slope for name in TILT_AND_STRAIN_NAMES)


class TiltAndStrainPart(NamedTuple):
    """Friction work and shift of the edges that tilt and bulk strain of finite bodies cause: the
    part of the bodies' effects that is odd in x.

    Attributes
    ----------
    second_order
        in the second order of tilt and strain (`odd_memory`): work of each cycle, and centres of
        contact and stick zone over time; None where the second order does not hold
    left_out
        why nothing is added; empty where something is, or where there is neither tilt nor strain
    work_on_grids
        work of each cycle by a numerical solution on grids, where the second order does not hold
        [energy per thickness]
    relative_uncertainty
        fraction of either work that is uncertain by the curvatures of the bodies and their next
        order
    """

    second_order: SecondOrderAnswer | None = None
    left_out: str = ""
    work_on_grids: Estimate | None = None
    relative_uncertainty: float = 0.0

    @property
    def has_work(self) -> bool:
        """Whether the work is known, by either way."""
        return self.second_order is not None or self.work_on_grids is not None

    def work(self, cycle: int) -> Estimate:
        """Friction work that tilt and bulk strain of the finite bodies add in a cycle, with its
        uncertainty [energy per thickness]. `cycle` is the index of the cycle, from 0, or from the
        end if negative.

        An index beyond the last known cycle takes that cycle. The work is 0 where none is known.
        Its source is the second order in tilt and strain, else a numerical solution on grids.
        """
        if not self.has_work:
            return ZERO_ESTIMATE  # 0, without uncertainty
        # On grids the work is the same in each cycle; the second order has one for each.
        added_work = self.work_on_grids
        if self.second_order is not None:
            works = self.second_order.works
            added_work = works[min(cycle, len(works) - 1)]
        assert added_work is not None  # for the type checker
        # relative_uncertainty: by what curvatures and next order of the bodies leave uncertain.
        uncertainty_by_curvatures = self.relative_uncertainty * abs(added_work.value)
        return Estimate(added_work.value, added_work.uncertainty + uncertainty_by_curvatures)

    def centres(self, time: Array) -> tuple[Array, Array]:
        """Centres x of contact and of the stick zone at instants (n,), (n,) each [length]; 0 where
        the second order does not hold.
        """
        if self.second_order is None:
            return np.zeros(len(time)), np.zeros(len(time))
        return self.second_order.centres(time)


class TiltAndStrainWords(NamedTuple):
    """Words of a note on an answer, which states the effects of finite bodies in its values.

    Attributes
    ----------
    if_taken
        what tilt and bulk strain change beside the dissipation, where they are taken
    if_left_out
        what is stated where tilt and bulk strain are left out
    even
        the other effects, even in x, that are in the values
    """

    if_taken: str
    if_left_out: str
    even: str


WORDS_UNDER_LOADS = TiltAndStrainWords(
    if_taken=(
        "move edges of contact and stick, in the first, and U and the approach of a parabola by the"
        " moment of the pressure; fields at points, shear at edges and edge tension are without"
        " them"
    ),
    if_left_out="are left out, but for the moment of the pressure in U and approach of a parabola",
    even="the curvatures N, N_Q, T, T_P, their next order and the compliances c_n, c_t",
)
WORDS_UNDER_RIG = TiltAndStrainWords(
    if_taken=(
        "change U of a parabola by the moment of the pressure; edges, fields at points, and P where"
        " the approach is prescribed, are without them"
    ),
    if_left_out="are left out, but for the moment of the pressure in U of a parabola",
    even="the curvatures N, N_Q, T, T_P and the compliances c_n, c_t",
)


def notes_of_effects(
    effects: BodyEffects,
    half_width: float,
    modulus: float,
    tilt_and_strain: TiltAndStrainPart,
    words: TiltAndStrainWords = WORDS_UNDER_LOADS,
) -> Iterator[str]:
    """Sentences for the notes of an answer: which effects of the finite bodies its values contain.

    Effects that are even in x (curvatures, compliances) are contained. The odd ones, tilt and bulk
    strain, are in the dissipation where the work that they add is known. Else the sentence states
    why they are left out, if a reason is given. Either way it states how large they are; there is
    no such sentence where all four are 0.

    Parameters
    ----------
    effects
        what the finite bodies add to the compliance of half-planes
    half_width, modulus
        contact half-width [length] and E* [stress], which make tilt and strain dimensionless
    tilt_and_strain
        `work(-1)` is the work that tilt and bulk strain add in the last cycle, by grids if
        `work_on_grids` is not None; `left_out` states why none is added
    words
        texts on the values that contain each kind of effect
    """
    yield f"effects: {words.even} of the bodies are in these values"
    odd_sizes = dimensionless_tilt_and_strain(effects, half_width, modulus)
    if not any(odd_sizes):
        return

    # alpha: tilt, e: bulk strain; of each P and Q cause a part.
    numbers_text = ", ".join(f"{odd_size:.3g}" for odd_size in odd_sizes)
    sizes_text = f"o = (alpha_P, alpha_Q, e_P, e_Q) P0/(a0/R) = ({numbers_text})"
    # Is the work that they add known? Else state why not, and what the order of their effect is.
    if tilt_and_strain.has_work:
        added_work = tilt_and_strain.work(-1)
        method = "in the second order" if tilt_and_strain.work_on_grids is None else "on grids"
        yield (
            f"effects: tilt and bulk strain of the bodies, {sizes_text}, add"
            f" {added_work.value:.3g} ± {added_work.uncertainty:.1g} to the dissipation, {method},"
            f" and {words.if_taken}"
        )
        return
    consequence = "which change the dissipation in the second order"

    # Dundurs' beta is 0 for like materials.
    if effects.dundurs_beta:
        consequence = "which change the dissipation in the first order: the materials are unlike"
    reason_text = ""
    if tilt_and_strain.left_out:
        reason_text = (
            f"; left out because {tilt_and_strain.left_out}; by how much the dissipation errs is"
            " not known"
        )
    yield (
        f"effects: tilt and bulk strain of the bodies {words.if_left_out},"
        f" {sizes_text}, {consequence}{reason_text}"
    )


def notes_of_batch(effects: BodyEffects) -> Iterator[str]:
    """Sentences for the notes of an array of answers: which effects of the finite bodies are in its
    values, and which are left out.

    How large tilt and strain are is not stated: that needs one contact half-width. N and N_Q are
    curvatures of the gap per P and per Q, T and T_P those of the faces per Q and per P. N_4, T_4,
    N_22 and T_22 are the terms of fourth order in x.
    """
    yield "effects: the curvatures N, N_Q, T, T_P of the bodies are in these values"
    if has_next_order(effects):
        yield (
            "effects: the next order of the bodies, N_4, T_4, N_22 and T_22, is left out; `solve`"
            " takes it"
        )
    # TILT_AND_STRAIN_NAMES: attributes with tilt under P and Q, strain under P and Q.
    if any(getattr(effects, name).value for name in TILT_AND_STRAIN_NAMES):
        yield (
            "effects: tilt and bulk strain of the bodies are left out; `solve` states how large"
            " they are for a scene"
        )


# ---------------------------------------------------------------------------------- rows of a path
@dataclass(frozen=True, eq=False)
class PathRows:
    """The rows of a path that is followed by straight steps: the instants at which a step ends and
    the next begins, with the loads of the contact there.

    Attributes
    ----------
    time, normal_load, tangential_load
        (n,) t, P and Q of each row [force per thickness]; P is 0 where the bodies are apart
    end_rows
        number of the row at which the initial loading ends, and of that at which each cycle ends;
        of the last row where there is no cycle
    period
        duration of a cycle, None for a path that does not repeat
    """

    time: Array
    normal_load: Array
    tangential_load: Array
    end_rows: tuple[int, ...]
    period: float | None

    @property
    def cycles(self) -> list[slice]:
        """Rows of each cycle as slices, from the one at which it begins to the one at which it
        ends. A path that does not repeat (`period` None) has all rows as a single slice.
        """
        if self.period is None:
            return [slice(0, len(self.time))]
        # end_rows: row at which the initial loading ends, then that at which each cycle ends.
        return [
            slice(self.end_rows[cycle], self.end_rows[cycle + 1] + 1)
            for cycle in range(len(self.end_rows) - 1)
        ]


@dataclass(frozen=True, eq=False)
class _HalfPlanePath:
    """A load path that was followed by half-plane theory: ends of its cycles, and P and Q at any
    instant.

    Attributes
    ----------
    scene
        whose loads are followed
    solved_path
        the solution of half-plane theory along the load path
    """

    scene: Scene
    solved_path: LoadSeries | History

    @cached_property
    def instants(self) -> Array:
        """Instants at which half-plane theory was solved: some 400 a cycle, events among them."""
        return self.solved_path.default_times(False, False)[0]

    @property
    def period(self) -> float | None:
        """Duration of a cycle."""
        return self.solved_path.period

    @property
    def start(self) -> float:
        """Time of the unloaded state."""
        return float(self.instants[0])

    @property
    def cycle_ends(self) -> list[float]:
        """Times of the ends of the initial loading and of the first two cycles, 3 in all, also
        where half-plane theory followed one cycle: the loads repeat. A path without cycle (`period`
        None) has two: its start and its end.
        """
        # instants: those at which half-plane theory was solved, ascending; start: the first of
        # them.
        end_time = float(self.instants[-1])
        if self.period is None:
            return [self.start, end_time]
        # solved_path.cycles: the cycles that half-plane theory followed.
        cycle_start = end_time - len(self.solved_path.cycles) * self.period
        return [cycle_start + k * self.period for k in range(3)]

    def rows(self, time: Array) -> PathRows:
        """Ends of the straight steps by which the load path is followed, with the loads P and Q
        there. They are the instants `time` (n,) that lie within the path, its start, and the ends
        of the cycles.

        Of two instants nearer than 1e-12 of the path's duration one is left out, never the end of
        a cycle. Where the bodies are pulled apart, P < 0, the load of the contact is 0.

        Raises
        ------
        InputError
            If more instants result than can be followed.
        """
        # Ends of the initial loading and of two cycles; start and end of a path without cycle.
        cycle_ends = self.cycle_ends
        path_duration = cycle_ends[-1] - self.start
        # _SAME_INSTANT_SHARE: 1e-12.
        times_in_path = time[(time > self.start) & (time < cycle_ends[-1])]
        time_to_nearest_end = np.min(
            np.abs(times_in_path[:, None] - np.array([self.start, *cycle_ends])), axis=1
        )
        times_in_path = times_in_path[time_to_nearest_end > _SAME_INSTANT_SHARE * path_duration]
        instants = np.unique(np.concatenate([times_in_path, [self.start], cycle_ends]))
        instants = instants[
            np.diff(instants, prepend=-np.inf) > _SAME_INSTANT_SHARE * path_duration
        ]

        # _MOST_ROWS: 200,000.
        if len(instants) > _MOST_ROWS:
            raise InputError(
                f"effects: the load path has {len(instants):,} rows and corrected theory follows"
                f" {_MOST_ROWS:,} at most: take a part of the path, or half-planes without effects"
            )

        # A series is linear between given rows of loads; any other path is a function of time.
        if isinstance(self.solved_path, LoadSeries):
            normal_load, tangential_load = _loads_of_series(self.solved_path, instants)
        else:
            normal_load, tangential_load = self.scene.load.path().at(instants)
        rows_of_ends = tuple(
            int(np.argmin(np.abs(instants - cycle_end))) for cycle_end in cycle_ends
        )

        # Without a cycle the path has its last row as the only end.
        if self.period is None:
            rows_of_ends = rows_of_ends[1:]
        contact_load = np.maximum(normal_load, 0.0)
        return PathRows(instants, contact_load, tangential_load, rows_of_ends, self.period)

    def first_rows(self, time: Array | None) -> PathRows:
        """First choice of the instants that cut the load path into straight steps, with P and Q
        there. They are those at which half-plane theory was solved, and `time` if it is given.

        Only two cycles are followed here; theory may have solved more. The instants of its last
        cycle, as a rule a steady one, are taken in both. A `time` after them is moved back by whole
        periods.
        """
        # Instants of half-plane theory; ends of the initial loading and of two cycles.
        instants = self.instants
        cycle_ends = self.cycle_ends
        path_end = cycle_ends[-1]
        if self.period is not None:
            # solved_path.cycles: the cycles that half-plane theory followed.
            time_before_last_cycle = (len(self.solved_path.cycles) - 1) * self.period
            instants_of_last_cycle = instants[instants >= cycle_ends[0] + time_before_last_cycle]
            instants_in_first_cycle = instants_of_last_cycle - time_before_last_cycle
            instants = np.concatenate(
                [instants, instants_in_first_cycle, instants_in_first_cycle + self.period]
            )
        if time is not None:
            # Whole periods back into the followed part of the path.
            time_in_path, _ = time_in_followed_path(time, self.start, path_end, self.period)
            instants = np.append(instants, np.clip(time_in_path, self.start, path_end))
        return self.rows(instants)

    def rows_with_turning_points(
        self,
        path_rows: PathRows,
        friction: float,
        curvatures_per_load: Curvatures,
        largest_parabola_load: float,
    ) -> PathRows:
        """Ends of the straight steps of a load path, with further instants at which slip begins or
        ends for six flat punches inside the contact. A path that is a series of loads keeps its
        steps.

        A punch goes on slipping while its Coulomb bound, the tangential force that is locked in up
        to it in slip, moves in the direction of slip. So slip may turn where the bound does:

            bound = Q - s f P + (s f kn - kt) G + constant,    s = +1 forward, -1 reverse

        kn and kt are the curvatures that the loads add to the gap and to the faces. G is the load
        that presses a parabola x^2/2 into contact up to the half-width of the punch. Half-planes,
        kn = kt = 0, have other turning points. The fourth order is left out of the bound here.

        Parameters
        ----------
        path_rows
            ends of the steps so far: `time` and the loads P and Q there, (n,) each
        friction
            f
        curvatures_per_load
            what the finite bodies add to kn and kt per unit of P and of Q
        largest_parabola_load
            G of the widest punch [force per thickness times length]
        """
        if isinstance(self.solved_path, LoadSeries):
            return path_rows
        normal_load = path_rows.normal_load
        tangential_load = path_rows.tangential_load

        # kn and kt at the rows.
        gap_curvature = curvatures_per_load.gap_curvature_under(normal_load, tangential_load)
        face_curvature = curvatures_per_load.face_curvature_under(normal_load, tangential_load)
        # Turning points of the bound in both directions, by punch; G of a punch is a fraction of
        # the largest.
        turning_times_of_punches = []

        # _PARABOLA_FRACTIONS: G of six punches over that of the largest, from 0 to 1.
        for direction in (1, -1):
            load_term = tangential_load - direction * friction * normal_load
            curvature_factor = direction * friction * gap_curvature - face_curvature
            for parabola_fraction in _PARABOLA_FRACTIONS:
                bound_of_punch = (
                    load_term + parabola_fraction * largest_parabola_load * curvature_factor
                )
                turning_times_of_punches.append(_turning_points(path_rows.time, bound_of_punch))
        turning_times = np.concatenate(turning_times_of_punches)
        times_inside_steps = _times_inside_steps(turning_times, path_rows.time)
        return self.rows(np.concatenate([path_rows.time, times_inside_steps]))


def _times_inside_steps(time: Array, step_ends: Array) -> Array:
    """Those of the times (n,) that lie well inside one of the steps between `step_ends` (r,),
    ascending: farther from both ends of the step than 2 % of its duration.
    """
    row_after = np.clip(np.searchsorted(step_ends, time), 1, len(step_ends) - 1)
    step_duration = step_ends[row_after] - step_ends[row_after - 1]
    fraction_of_step = (time - step_ends[row_after - 1]) / step_duration
    # _STEP_SHARE_AT_ROW: 0.02
    is_inside_step = (fraction_of_step > _STEP_SHARE_AT_ROW) & (
        fraction_of_step < 1 - _STEP_SHARE_AT_ROW
    )
    return time[is_inside_step]


def _turning_points(time: Array, values: Array) -> Array:
    """Times at which a sampled function has a maximum or minimum: vertices of the parabolas through
    three successive points, where the slope changes its sign. `values` (n,) are its values at
    `time` (n,).
    """
    durations = np.diff(time)
    slopes = np.diff(values) / durations
    turning_rows = np.flatnonzero(slopes[1:] * slopes[:-1] < 0) + 1
    slopes_before = slopes[turning_rows - 1]
    second_derivatives = (slopes[turning_rows] - slopes_before) / (
        (durations[turning_rows - 1] + durations[turning_rows]) / 2
    )
    middle_times = (time[turning_rows - 1] + time[turning_rows]) / 2
    return np.asarray(middle_times - slopes_before / second_derivatives)


def _loads_of_series(series: LoadSeries, time: Array) -> tuple[Array, Array]:
    """P and Q of a load series, linear between its rows, at instants `time` (n,), (n,) each; also
    in cycles after those that theory followed.

    Parameters
    ----------
    series
        load path that is linear between rows; each of its `parts` (initial loading, cycles) has
        `rows` (r, 3) of time, P and Q and a `delay`, the time at which it begins;
        `period` is the duration of a cycle or None
    time
        (n,) instants
    """
    rows_of_series = np.concatenate(
        [part.rows + np.array([part.delay, 0.0, 0.0]) for part in series.parts]
    )
    # Instants after the last row go back by whole periods; a slack of 1e-12 periods is allowed.
    time_in_path = time
    if series.period is not None:
        path_end = float(rows_of_series[-1, 0])
        periods_beyond = np.maximum(
            np.ceil((time - path_end) / series.period - _SAME_INSTANT_SHARE), 0.0
        )
        time_in_path = time - periods_beyond * series.period
    return np.interp(time_in_path, rows_of_series[:, 0], rows_of_series[:, 1]), np.interp(
        time_in_path, rows_of_series[:, 0], rows_of_series[:, 2]
    )


# ----------------------------------------------------------------------------------------- fields
@dataclass(frozen=True, eq=False)
class PathSeries:
    """Half-widths, displacements and friction work at the n instants (rows) of a followed path.

    Attributes
    ----------
    followed_path
        friction memory and slip zones along the path
    contact, modulus
        normal contact of half-planes, E* [stress]
    effects
        what the bodies add; None: nothing
    rigid_displacement
        (n,) how far the bodies slid as a whole or moved while apart [length]; None: they never did
    """

    followed_path: FollowedPath
    contact: SymmetricContact
    modulus: float
    effects: BodyEffects | None
    rigid_displacement: Array | None = None

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of instants ("rows") and of pieces of memory curves, by name."""
        return {
            "rows": len(self.followed_path.normal_load),
            "pieces": len(self.followed_path.pieces.top_s),
        }

    @property
    def unit_compliance(self) -> float:
        """A/pi = 2/(pi E*) [1/stress]."""
        return 2 / (math.pi * self.modulus)

    @cached_property
    def half_width(self) -> Array:
        """Contact half-width a, (n,) [length]; while bodies are apart that of the flat, or 0."""
        # edge_s: coordinate s of the edge of contact in the table of flat punches, which gives
        # c(s). least_half_width: of the flat part of the profile, 0 without one.
        half_width = self.followed_path.table.half_width(self.followed_path.edge_s)
        return np.where(
            self.followed_path.normal_load > 0, half_width, self.contact.least_half_width
        )

    @cached_property
    def stick_half_width(self) -> Array:
        """Half-width c of the stick zone, (n,) [length]; a in full stick and while bodies are
        apart, NaN in full slip and where a is 0.
        """
        # followed_path: friction memory and slip zones. slip_direction: +1 or -1, 0 in full stick;
        # innermost_slip_s: coordinate s of the inner end of all slip zones in the table of flat
        # punches, 0 in full slip.
        followed_path = self.followed_path
        has_slip = followed_path.slip_direction != 0
        half_width_of_slip = followed_path.table.half_width(followed_path.innermost_slip_s)
        stick_half_width = np.where(has_slip, half_width_of_slip, self.half_width)
        is_full_slip = has_slip & (followed_path.innermost_slip_s <= 0)
        return np.where((stick_half_width <= 0) | is_full_slip, np.nan, stick_half_width)

    @cached_property
    def tangential_displacement(self) -> Array:
        """Relative tangential displacement U of the two bodies at each instant of the path, (n,)
        [length].

            U = (A/pi) int ln(2 L/c) dM + c_t Q + T q_2/2 + N_Q p_2/2 + T_4 q_4/24

        plus sliding as a whole, plus what tilt adds. The integral is that of half-planes; the rest
        is by finite bodies. p_k and q_k are the moments int x^k p dx and int x^k q dx; T, N_Q, T_4
        are curvatures per load, c_t is a compliance.

        # notation: A = 2/E*, L datum length, c half-width of a flat punch, M tangential force that
        #           the punches up to c carry
        """
        # shear_integral: int ln(2 L/c) dM; unit_compliance: A/pi.
        _, shear_integral = self._logarithm_integrals
        displacement = self.unit_compliance * shear_integral
        if self.rigid_displacement is not None:
            displacement = displacement + self.rigid_displacement
        if self.effects is None:
            return displacement

        # Of the curvatures: `tangential` is T, `normal_under_shear` N_Q, `tangential_fourth` T_4.
        curvatures_per_load = curvatures_of(self.effects)
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self.followed_path

        # T q_2 + N_Q p_2 + T_4 q_4/12
        # shear_second_moment: q_2, pressure_second_moment: p_2, shear_fourth_moment: q_4, (n,)
        # each.
        twice_moment_terms = curvatures_per_load.tangential * followed_path.shear_second_moment
        twice_moment_terms = (
            twice_moment_terms
            + curvatures_per_load.normal_under_shear * followed_path.pressure_second_moment
        )
        if curvatures_per_load.tangential_fourth:
            twice_moment_terms = (
                twice_moment_terms
                + curvatures_per_load.tangential_fourth * followed_path.shear_fourth_moment / 12
            )
        displacement_by_compliance = (
            self.effects.tangential_compliance.value * followed_path.tangential_load
        )
        displacement_by_tilt, _ = self._displacements_by_tilt
        return np.asarray(
            displacement
            + displacement_by_compliance
            + twice_moment_terms / 2
            + displacement_by_tilt
        )

    @cached_property
    def normal_approach(self) -> Array:
        """Normal approach of the two bodies at each instant of the path, (n,) [length].

            approach = (A/pi) int ln(2 L/c) dP + c_n P + N p_2/2 + T_P q_2/2 + N_4 p_4/24

        plus what tilt adds. The integral is that of half-planes; the rest is by finite bodies. p_k
        and q_k are the moments int x^k p dx and int x^k q dx; N, T_P, N_4 are curvatures per load,
        c_n is a compliance.

        # notation: A = 2/E*, L datum length, c half-width of a flat punch, P here the normal load
        #           that the punches up to c carry
        """
        # pressure_integral: int ln(2 L/c) dP; unit_compliance: A/pi.
        pressure_integral, _ = self._logarithm_integrals
        approach = self.unit_compliance * pressure_integral
        if self.effects is None:
            return approach
        # Of the curvatures: `normal` is N, `tangential_under_pressure` T_P, `normal_fourth` N_4.
        curvatures_per_load = curvatures_of(self.effects)
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self.followed_path
        # N p_2 + T_P q_2 + N_4 p_4/12
        # pressure_second_moment: p_2, shear_second_moment: q_2, pressure_fourth_moment: p_4, (n,)
        # each.
        twice_moment_terms = curvatures_per_load.normal * followed_path.pressure_second_moment
        twice_moment_terms = (
            twice_moment_terms
            + curvatures_per_load.tangential_under_pressure * followed_path.shear_second_moment
        )
        if curvatures_per_load.normal_fourth:
            twice_moment_terms = (
                twice_moment_terms
                + curvatures_per_load.normal_fourth * followed_path.pressure_fourth_moment / 12
            )
        approach_by_compliance = self.effects.normal_compliance.value * followed_path.normal_load
        _, approach_by_tilt = self._displacements_by_tilt
        return np.asarray(
            approach + approach_by_compliance + twice_moment_terms / 2 + approach_by_tilt
        )

    @cached_property
    def _displacements_by_tilt(self) -> tuple[Array, Array]:
        """Displacements that the tilt of finite bodies adds to U and to the normal approach, (n,)
        each [length]; 0 unless the profile is a parabola.

        A parabola of radius R tilted by alpha = alpha_P P + alpha_Q Q touches about x = -alpha R.
        The moment of its pressure is then m = -R alpha P. By reciprocity m moves the bodies by
        alpha_Q m tangentially and alpha_P m normally. A tilted parabola is pressed in by R
        alpha^2/2 less.

        # notation: P, Q normal and tangential load of the contact, alpha_P, alpha_Q tilt per unit
        #           of each, U relative tangential displacement
        """
        # HertzContact: contact of a parabola of radius `radius`.
        normal_load = self.followed_path.normal_load
        no_displacement = np.zeros(len(normal_load))
        if self.effects is None or not isinstance(self.contact, HertzContact):
            return no_displacement, no_displacement
        # Of the effects: tilt_under_pressure is alpha_P, tilt_under_shear alpha_Q.
        tilt_per_normal = self.effects.tilt_under_pressure.value
        tilt_per_tangential = self.effects.tilt_under_shear.value
        tilt = (
            tilt_per_normal * normal_load + tilt_per_tangential * self.followed_path.tangential_load
        )
        moment = -self.contact.radius * tilt * normal_load
        approach_lost = self.contact.radius * tilt**2 / 2
        return tilt_per_tangential * moment, tilt_per_normal * moment - approach_lost

    @cached_property
    def _logarithm_integrals(self) -> tuple[Array, Array]:
        """int ln(2 L/c) dP and int ln(2 L/c) dM over the flat punches of half-width c, (n,) each
        [force per thickness]. Times A/pi, A = 2/E*, they are displacements of half-planes with
        datum length L.

        P(c) and M(c) are the normal and the tangential force that punches up to c carry.

        With finite bodies L is the datum length of their effects, else that of the contact. Both
        integrals are 0 while the bodies are apart.
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self.followed_path
        datum_length = (
            self.contact.datum_length if self.effects is None else self.effects.datum_length
        )
        # M(c) is a chain of pieces: the integrals up to the top of each piece, and up to the edge
        # of contact at each instant. top_s and edge_s: coordinate s of the half-width c in the
        # table.
        integrals_at_tops = followed_path.table.logarithm_integrals(
            followed_path.pieces.top_s, datum_length
        )
        integrals_at_edge = followed_path.table.logarithm_integrals(
            followed_path.edge_s, datum_length
        )
        # Sums over the punches: pressure_integral weights with dP, shear_integral with dM.
        return followed_path.pressure_integral(integrals_at_edge), followed_path.shear_integral(
            integrals_at_tops, integrals_at_edge
        )

    @cached_property
    def _shear_signs_beyond_limit(self) -> Indices:
        """Sign of the shear q of the memory curve at each instant, (n,), where |q| exceeds the
        Coulomb limit f p most; 0 if it does nowhere inside the contact. There points slip further.

        The memory curve is the locked-in tangential force of the flat punches up to each
        half-width. Only curvatures of finite bodies make an excess possible. A few places are
        checked first, more at suspect instants and at two instants on either side of them. An
        excess below 3e-7 of f times the pressure at x = 0 under the largest P counts as 0.
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self.followed_path
        shear_signs = np.zeros(len(followed_path.edge_s), dtype=np.int64)
        # Curvatures x^2/2 and x^4/24 that the loads add to gap and faces, (n,) each.
        curvatures_at_instants = (
            followed_path.normal_curvature,
            followed_path.tangential_curvature,
            followed_path.normal_fourth,
            followed_path.tangential_fourth,
        )
        if not np.any(curvatures_at_instants):
            return shear_signs
        # Pressure at x = 0 under the largest P.
        row_of_largest_load = np.array([np.argmax(followed_path.normal_load)])
        central_pressure = float(PointFields(self, np.zeros(1)).pressure(row_of_largest_load)[0, 0])
        excess_tolerance = _EXCESS_TOLERANCE_SHARE * followed_path.friction * central_pressure
        # A few places may miss the largest excess: a hundredth of it is suspect.
        all_rows = np.arange(len(shear_signs))
        # _PLACES_CHECKED_FIRST: 30 places, _PLACES_CHECKED: 100.
        # Largest |q| - f p of each instant, over so many places, and the sign of q there.
        largest_excess, _ = self._excess_over_limit(all_rows, _PLACES_CHECKED_FIRST)
        is_suspect = (largest_excess > excess_tolerance / 100).astype(float)
        # The instant itself, and two on either side.
        rows_to_check = np.flatnonzero(np.convolve(is_suspect, np.ones(5), mode="same"))
        largest_excess, signs_of_shear = self._excess_over_limit(rows_to_check, _PLACES_CHECKED)
        shear_signs[rows_to_check] = np.where(largest_excess > excess_tolerance, signs_of_shear, 0)
        return shear_signs

    def _excess_over_limit(self, row_numbers: Indices, n_places: int) -> tuple[Array, Array]:
        """By how much the shear of the memory curve exceeds the Coulomb limit, max(|q| - f p)
        [stress], and the sign of q there, at the instants of these numbers, (n,) each.

        The memory curve is the locked-in tangential force of the flat punches up to each
        half-width. The maximum is over `n_places` places from the middle to the edge of the path's
        largest contact. It is 0 at the least: outside the contact q and p are 0.
        """
        fractions_of_half_width = np.sin(np.linspace(0.0, math.pi / 2, n_places))
        fields_of_places = PointFields(
            self, float(np.max(self.half_width)) * fractions_of_half_width
        )
        largest_excess = np.zeros(len(row_numbers))
        signs_of_shear = np.zeros(len(row_numbers))
        # Many instants at once, _ROWS_AT_ONCE = 2000, to bound the storage.
        for chunk_start in range(0, len(row_numbers), _ROWS_AT_ONCE):
            rows_of_chunk = slice(chunk_start, chunk_start + _ROWS_AT_ONCE)
            shear = fields_of_places.shear_of_memory(row_numbers[rows_of_chunk])
            coulomb_limit = self.followed_path.friction * fields_of_places.pressure(
                row_numbers[rows_of_chunk]
            )
            excess = np.nan_to_num(np.abs(shear) - coulomb_limit)
            place_of_largest_excess = np.argmax(excess, axis=1)[:, None]
            largest_excess[rows_of_chunk] = np.take_along_axis(
                excess, place_of_largest_excess, axis=1
            )[:, 0]
            signs_of_shear[rows_of_chunk] = np.sign(
                np.take_along_axis(shear, place_of_largest_excess, axis=1)[:, 0]
            )
        return largest_excess, signs_of_shear

    @cached_property
    def _inner_slips_by_row(self) -> dict[int, InnerSlip]:
        """Extra slip by the number of its instant, as far as it was asked for."""
        return {}

    def inner_slips(self, row_numbers: Indices) -> Iterator[tuple[int, InnerSlip]]:
        """Extra slip inside the contact, each with the index of its instant in `row_numbers`. It
        exists at those of these instants at which the shear |q| of the memory curve exceeds the
        Coulomb limit f p.

        The memory curve is the locked-in tangential force of the flat punches up to each
        half-width. Extra slip that was computed before is taken from a cache.
        """
        # _shear_signs_beyond_limit: sign of q where it exceeds the limit, else 0, by instant.
        for index in np.flatnonzero(self._shear_signs_beyond_limit[row_numbers]).tolist():
            row = int(row_numbers[index])
            if row not in self._inner_slips_by_row:
                self._inner_slips_by_row[row] = self._computed_inner_slip(row)
            yield index, self._inner_slips_by_row[row]

    def _computed_inner_slip(self, row: int) -> InnerSlip:
        """Extra slip inside the contact at instant number `row`, where the shear of the memory
        curve exceeds the Coulomb limit, |q| > f p.

        The memory curve is the locked-in tangential force of the flat punches up to each
        half-width. The extra slip is the least that brings |q| down to f p. It follows from q and f
        p as functions of x, and from three kinds of half-widths: of contact, of stick, and of the
        ends of slip zones. The returned record gives the slip and its shear at any points.
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self.followed_path

        def shear_and_limit(x: Array) -> tuple[Array, Array]:
            """q of the memory curve and f p at distances x (k,) from the middle, (k,) each."""
            fields_at_x = PointFields(self, x)
            shear = fields_at_x.shear_at(row)
            pressure = fields_at_x.pressure(np.array([row]))[0]
            return shear, followed_path.friction * pressure

        # stick_edge_s, inner_zone_s: coordinates s of the stick edge and of both ends of an inner
        # slip zone in the table of punches.
        contact_half_width = float(self.half_width[row])
        half_widths_at_zone_ends = followed_path.table.half_width(
            [followed_path.stick_edge_s[row], *followed_path.inner_zone_s[row]]
        )

        # direction: that of slip at the edge of contact, 0 where it sticks: then the stick zone of
        # the memory curve reaches that edge.
        stick_half_width = (
            half_widths_at_zone_ends[0] if followed_path.direction[row] else contact_half_width
        )

        # Sign of q where it exceeds f p: slip has that direction.
        direction_of_extra_slip = int(self._shear_signs_beyond_limit[row])
        return inner_slip(
            shear_and_limit,
            direction_of_extra_slip,
            contact_half_width,
            half_widths_at_zone_ends,
            stick_half_width,
            self.modulus,
        )

    def loop_work(self, cycle_rows: slice) -> float:
        """Work of the loads in a cycle, the closed integral of Q dU + P d(approach), for its
        instants `cycle_rows` [energy per thickness].
        """
        # area_of_loop: integral of a load over its displacement, by the trapezoidal rule.
        followed_path = self.followed_path
        tangential_work = area_of_loop(
            followed_path.tangential_load[cycle_rows], self.tangential_displacement[cycle_rows]
        )
        normal_work = area_of_loop(
            followed_path.normal_load[cycle_rows], self.normal_approach[cycle_rows]
        )
        return tangential_work + normal_work

    def work(self, cycle_rows: slice) -> float:
        """Friction work of all steps of a cycle, or of the path, for its instants `cycle_rows`
        [energy per thickness].
        """
        # step_work: work of the step that ends at each instant, without the factor A/pi; the first
        # instant ends none of this cycle.
        return self.unit_compliance * float(np.sum(self.followed_path.step_work[cycle_rows][1:]))


class PointFields:
    """Pressure, shear, slip and friction work of a followed path at distances |x| from the middle
    of contact.

    Parameters
    ----------
    series
        the followed path
    x
        (k,) distances |x| of the points [length]
    """

    def __init__(self, series: PathSeries, x: Array) -> None:
        """Keep the followed path and the distances |x| (k,) at which fields are evaluated."""
        self.series = series
        self._followed_path = series.followed_path
        self._x = x
        # The last slip (n, k) that was computed, and the numbers of its instants, ascending (n,).
        self._known_slip: tuple[Indices, Array] = (np.zeros(0, dtype=np.int64), np.zeros((0, 0)))

    def pressure(self, row_numbers: Indices) -> Array:
        """Contact pressure p at instants number `row_numbers` (n,), at the k points, (n, k)
        [stress]. It is that of the profile plus that by the curvature which the bodies add to the
        gap.
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self._followed_path
        # Load that the flat punches of the profile carry up to the edge of contact, coordinate
        # edge_s.
        profile_load = followed_path.table.profile_load(followed_path.edge_s[row_numbers])[:, None]
        # series.contact: normal contact of half-planes; self._x: |x| of the k points.
        profile_pressure = self.series.contact.pressure(self._x, profile_load)
        # kn and n4 at these instants: factors of x^2/2 and x^4/24 in the gap.
        gap_curvature = followed_path.normal_curvature[row_numbers]
        fourth_coefficient = followed_path.normal_fourth[row_numbers]
        return profile_pressure + self._traction_of_curvature(
            self.series.half_width[row_numbers], gap_curvature, fourth_coefficient
        )

    def shear(self, row_numbers: Indices) -> Array:
        """Shear traction q at instants number `row_numbers` (n,), at the k points, (n, k) [stress],
        with the extra slip inside the contact.
        """
        shear = self.shear_of_memory(row_numbers)
        for index, extra_slip in self.inner_slips(row_numbers):
            shear[index] += extra_slip.shear
        return shear

    def shear_of_memory(self, row_numbers: Indices) -> Array:
        """Shear traction q at instants number `row_numbers` (n,), at the k points, (n, k) [stress],
        without the extra slip inside the contact.

        It is the shear of the memory curve plus that by the curvature which the loads give to the
        faces. The curve is the locked-in tangential force of the flat punches up to each
        half-width.
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self._followed_path
        # By kt and t4, the factors of x^2/2 and x^4/24 in the tangential displacement of the faces.
        # series: the followed path, with its contact half-width.
        shear_of_faces = self._traction_of_curvature(
            self.series.half_width[row_numbers],
            followed_path.tangential_curvature[row_numbers],
            followed_path.tangential_fourth[row_numbers],
        )
        return self._shear_of_memory_curves(row_numbers) + shear_of_faces

    def shear_at(self, row: int) -> Array:
        """Shear traction q at the k points at the single instant number `row`, (k,) [stress],
        without the extra slip inside the contact.

        The memory curve is the locked-in tangential force F of the flat punches up to each
        half-width. It is a chain of pieces from the middle outwards. On each piece F is linear in
        eta, G and G_4, the loads that press the profile, x^2/2 and x^4/24 into contact up to that
        half-width. Each piece adds its slopes times the pressure of its punches. The curvature that
        the loads give to the faces adds the rest.
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self._followed_path
        pieces = followed_path.pieces
        # From the empty curve, number 0, which has no punches, to the uppermost piece.
        piece_numbers = pieces.piece_numbers_of_curve(int(followed_path.uppermost_piece[row]))
        # Pressures of the punches up to the top of each piece, (pieces, k): of the profile, of
        # x^2/2 and of x^4/24. top_s: coordinate s of the top in the table of punches.
        # series.contact: normal contact of half-planes; self._x: |x| of the k points.
        profile_pressures = self.series.contact.pressure_rise(
            self._x, pieces.profile_load[piece_numbers, None]
        )
        parabola_pressures, fourth_pressures = self._pressures_of_curvature(
            followed_path.table.half_width(pieces.top_s[piece_numbers])
        )
        # Slopes of F on each piece: per d eta, dG and dG_4.
        shear = pieces.profile_slope[piece_numbers[1:]] @ np.diff(profile_pressures, axis=0)
        shear = shear + pieces.parabola_slope[piece_numbers[1:]] @ np.diff(
            parabola_pressures, axis=0
        )
        shear = shear + pieces.fourth_slope[piece_numbers[1:]] @ np.diff(fourth_pressures, axis=0)
        # By kt and t4, the factors of x^2/2 and x^4/24 in the tangential displacement of the faces.
        shear_of_faces = self._traction_of_curvature(
            self.series.half_width[[row]],
            followed_path.tangential_curvature[[row]],
            followed_path.tangential_fourth[[row]],
        )
        return np.asarray(shear + shear_of_faces[0])

    def slip(self, row_numbers: Indices) -> Array:
        """Relative slip s of the faces at instants number `row_numbers` (n,), at the k points, (n,
        k) [length].

        The last slip that was computed is kept. It is used again if it contains all of these
        instants.
        """
        # Numbers of the instants of the kept slip, ascending, and that slip.
        known_rows, known_slip = self._known_slip
        if len(known_rows):
            index_in_known_rows = np.minimum(
                np.searchsorted(known_rows, row_numbers), len(known_rows) - 1
            )
            if np.array_equal(known_rows[index_in_known_rows], row_numbers):
                return known_slip[index_in_known_rows]
        slip = self._computed_slip(row_numbers)
        if np.all(np.diff(row_numbers) > 0):  # ascending, as a search among them needs
            self._known_slip = (row_numbers, slip)
        return slip

    def _computed_slip(self, row_numbers: Indices) -> Array:
        """Relative slip s of the faces at n instants `row_numbers`, at the k points, (n, k)
        [length].

        It is the sum of four parts:

        - slip by the memory curves;
        - slip by the curvature that the loads give to the faces, outside the contact;
        - sliding as a whole, and movement while the bodies are apart;
        - the extra slip inside the contact.

        A memory curve is the locked-in tangential force of the flat punches up to each half-width.
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self._followed_path
        slip = self._slip_of_memory_curves(row_numbers)
        # kt and t4: factors of x^2/2 and x^4/24 in the tangential displacement of the faces.
        # Inside the contact what sticks follows the curvature of the faces; outside it does not.
        face_curvature = followed_path.tangential_curvature[row_numbers, None]
        fourth_coefficient = followed_path.tangential_fourth[row_numbers, None]
        if np.any(face_curvature) or np.any(fourth_coefficient):
            # Displacements per curvature that punches up to the edge of contact make at the points.
            parabola_integral, fourth_integral = self._slip_integrals(
                self.series.half_width[row_numbers]
            )
            # self._x: |x| of the k points.
            slip = slip + face_curvature * (parabola_integral - self._x**2 / 2)
            slip = slip + fourth_coefficient * (fourth_integral - self._x**4 / 24)
        # rigid_displacement: sliding as a whole and movement while apart, (n,) [length].
        if self.series.rigid_displacement is not None:
            slip = slip + self.series.rigid_displacement[row_numbers, None]
        for index, extra_slip in self.inner_slips(row_numbers):
            slip[index] += extra_slip.slip
        return np.asarray(slip)

    def inner_slips(self, row_numbers: Indices) -> Iterator[tuple[int, SlipAtPoints]]:
        """Shear and slip that the extra slip adds at the k points, each with the index of its
        instant in `row_numbers`. It exists at those of these instants at which |q| of the memory
        curve exceeds f p.

        The memory curve is the locked-in tangential force of the flat punches up to each
        half-width. What was computed before for an instant is taken from a cache.
        """
        for index, inner_slip_of_row in self.series.inner_slips(row_numbers):
            row = int(row_numbers[index])
            if row not in self._inner_slips_by_row:
                # self._x: |x| of the k points.
                self._inner_slips_by_row[row] = inner_slip_of_row.at_points(self._x)
            yield index, self._inner_slips_by_row[row]

    @cached_property
    def _inner_slips_by_row(self) -> dict[int, SlipAtPoints]:
        """Extra slip at the points by the number of its instant, as far as it was asked for."""
        return {}

    def work_density(self, cycle_rows: slice) -> Array:
        """Friction work per area W(x) of one cycle at the points, (k,) [force per length], for the
        instants `cycle_rows` of that cycle.

        Each step adds the mean of f p at its two ends times the distance that the point slips. A
        step in full stick adds nothing. Nor does any step at points inside the smaller of the stick
        zones at its two ends. A pressure that is not finite counts as 0.
        """
        # edge_s has one entry per instant: its length is the number of instants.
        row_numbers = np.arange(len(self._followed_path.edge_s))[cycle_rows]
        friction_limit = self._followed_path.friction * self.pressure(row_numbers)
        friction_limit = np.where(np.isfinite(friction_limit), friction_limit, 0.0)
        mean_limit = (friction_limit[1:] + friction_limit[:-1]) / 2
        # Slip in each step, and half-width that sticks at both of its ends, 0 for none.
        slip_distance = np.abs(np.diff(self.slip(row_numbers), axis=0))
        # series: the followed path, with its stick half-width; NaN where nothing sticks.
        stick_half_width = np.nan_to_num(self.series.stick_half_width[row_numbers])
        least_stick_half_width = np.minimum(stick_half_width[1:], stick_half_width[:-1])[:, None]
        # slip_direction: of the step that ends at the instant, 0 in full stick.
        step_has_slip = self._followed_path.slip_direction[row_numbers[1:], None] != 0
        # self._x: |x| of the k points.
        point_slips = step_has_slip & (self._x >= least_stick_half_width)
        return np.asarray(np.sum(np.where(point_slips, mean_limit * slip_distance, 0.0), axis=0))

    def _shear_of_memory_curves(self, row_numbers: Indices) -> Array:
        """Shear traction that the memory curves carry at n instants `row_numbers`, at the k points,
        (n, k) [stress].

        A memory curve is the locked-in tangential force F of the flat punches up to each
        half-width. On each of its pieces dF = profile_slope d eta + parabola_slope dG +
        fourth_slope dG_4. The shear is the integral of dF times the pressure that a punch makes per
        unit load.

        # notation: eta, G, G_4 loads that press the profile, x^2/2 and x^4/24 into contact up to
        #           that half-width; profile_slope etc. dF per unit of each
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self._followed_path
        # Only the pieces that these instants need, with the number of the uppermost piece of each
        # curve.
        needed_pieces, uppermost_pieces = followed_path.pieces.pieces_of_curves(
            followed_path.uppermost_piece[row_numbers]
        )
        # Pressures of the punches up to the top of each piece, (pieces, k). top_s: coordinate s of
        # the top in the table of punches.
        # series.contact: normal contact of half-planes; self._x: |x| of the k points.
        profile_pressures = self.series.contact.pressure_rise(
            self._x, needed_pieces.profile_load[:, None]
        )
        slopes_and_pressures = [(needed_pieces.profile_slope, profile_pressures)]
        if np.any(needed_pieces.parabola_slope) or np.any(needed_pieces.fourth_slope):
            parabola_pressures, fourth_pressures = self._pressures_of_curvature(
                followed_path.table.half_width(needed_pieces.top_s)
            )
            slopes_and_pressures += [
                (needed_pieces.parabola_slope, parabola_pressures),
                (needed_pieces.fourth_slope, fourth_pressures),
            ]
        # Sums along each curve from the middle of the contact to the top of each piece.
        return needed_pieces.integrals_at_tops(*slopes_and_pressures)[uppermost_pieces]

    def _slip_of_memory_curves(self, row_numbers: Indices) -> Array:
        """Slip by the memory curves at n instants `row_numbers`, at the k points, (n, k) [length].

        A memory curve is the locked-in tangential force F of the flat punches up to each
        half-width. The slip is the integral of dF times the slip that a punch under unit force
        makes outside of itself. On each piece of the curve dF = profile_slope d eta +
        parabola_slope dG + fourth_slope dG_4.

        # notation: eta, G, G_4 loads that press the profile, x^2/2 and x^4/24 into contact up to
        #           that half-width
        """
        # followed_path: friction memory, loads, edges of contact and stick at all instants.
        followed_path = self._followed_path
        # Only the pieces that these instants need, with the number of the uppermost piece of each
        # curve.
        needed_pieces, uppermost_pieces = followed_path.pieces.pieces_of_curves(
            followed_path.uppermost_piece[row_numbers]
        )
        # Integrals over the punches up to the top of each piece, (pieces, k): of arccosh(|x|/c) d
        # eta, then of the slip under x^2/2 and x^4/24. unit_compliance: A/pi. top_s: coordinate s
        # of the top.
        # series.contact: normal contact of half-planes; self._x: |x| of the k points.
        profile_integrals = self.series.contact.slip_integral(
            self._x, needed_pieces.profile_load[:, None]
        )
        slopes_and_integrals = [
            (self.series.unit_compliance * needed_pieces.profile_slope, profile_integrals)
        ]
        if np.any(needed_pieces.parabola_slope) or np.any(needed_pieces.fourth_slope):
            parabola_integrals, fourth_integrals = self._slip_integrals(
                followed_path.table.half_width(needed_pieces.top_s)
            )
            slopes_and_integrals += [
                (needed_pieces.parabola_slope, parabola_integrals),
                (needed_pieces.fourth_slope, fourth_integrals),
            ]
        # Sums along each curve from the middle of the contact to the top of each piece.
        return needed_pieces.integrals_at_tops(*slopes_and_integrals)[uppermost_pieces]

    def _traction_of_curvature(
        self, half_width: Array, curvature: Array, fourth_coefficient: Array
    ) -> Array:
        """Traction at the k points by which contacts of given half-widths make up for C x^2/2 + D
        x^4/24, (n, k) [stress]; 0 outside the contact.

        If bodies add these terms to the gap, the traction is a pressure, as under an indenter of
        that shape. If they add them to the displacement along the faces, it is a shear. Inside the
        contact it displaces half-planes by the opposite, up to a constant. C is `curvature` (n,)
        and D `fourth_coefficient` (n,), one of each per contact.
        """
        if not (np.any(curvature) or np.any(fourth_coefficient)):
            # self._x: |x| of the k points.
            return np.zeros((len(half_width), len(self._x)))
        parabola_pressure, fourth_pressure = self._pressures_of_curvature(half_width)
        return np.asarray(
            curvature[:, None] * parabola_pressure + fourth_coefficient[:, None] * fourth_pressure
        )

    def _pressures_of_curvature(self, half_width: Array) -> tuple[Array, Array]:
        """Pressure at the k points under indenters x^2/2 and x^4/24 with contact half-widths a
        (n,), (n, k) each, 0 outside: [stress length] and [stress length^3].

            (E*/2) sqrt(a^2 - x^2),    (E*/24) sqrt(a^2 - x^2) (a^2 + 2 x^2)
        """
        # self._x: |x| of the k points; series.modulus: E*.
        half_width_column = half_width[:, None]
        square_root = np.sqrt(
            np.maximum((half_width_column - self._x) * (half_width_column + self._x), 0.0)
        )
        parabola_pressure = self.series.modulus / 2 * square_root
        fourth_pressure = parabola_pressure * ((half_width_column**2 + 2 * self._x**2) / 12)
        return parabola_pressure, fourth_pressure

    def _slip_integrals(self, half_width: Array) -> tuple[Array, Array]:
        """Integrals over flat punches that give the slip of each of k points outside of them, for a
        parabola and for x^4/24, (n, k) each [length^2, length^4].

        With c the half-width of a punch and a the upper limit `half_width` (n,), over c < min(a,
        |x|):

            int c arccosh(|x|/c) dc,    int (c^3/4) arccosh(|x|/c) dc

        Slip is such an integral times a slope of the memory curve, the locked-in tangential force
        of the flat punches up to each half-width.
        """
        # |x| of the k points.
        x = self._x
        upper_limit = np.minimum(half_width[:, None], x)
        squared_limit = upper_limit**2
        square_root = np.sqrt(np.maximum(x**2 - squared_limit, 0.0))
        # c^2 arccosh(|x|/c) at the upper limit
        arccosh_term = (
            np.arcsinh(square_root / np.where(upper_limit > 0, upper_limit, np.inf)) * squared_limit
        )
        parabola_integral = (arccosh_term + x * (x - square_root)) / 2
        fourth_integral = (
            squared_limit * arccosh_term
            + x * (2 / 3 * x**3 - x**2 * square_root + square_root**3 / 3)
        ) / 16
        return np.asarray(parabola_integral), np.asarray(fourth_integral)


# --------------------------------------------------------------------------------- the whole answer
@dataclass(frozen=True, eq=False)
class _Paths:
    """A load path that was followed twice by the same straight steps: with finite bodies, and with
    half-planes.

    Attributes
    ----------
    question
        request that is answered
    path_rows
        instants between the steps, with the loads there
    path_with_bodies, path_of_half_planes
        the path with finite bodies, and with half-planes
    steady_from
        index of the first cycle that ends in the state it started from, None if none does
    covered_cycles
        for each whole cycle of the answer, the index of the followed cycle that it equals
    """

    question: Question
    path_rows: PathRows
    path_with_bodies: PathSeries
    path_of_half_planes: PathSeries
    steady_from: int | None
    covered_cycles: tuple[int, ...]

    @property
    def last_cycle(self) -> slice:
        """Rows of the last covered cycle."""
        return self.path_rows.cycles[self.covered_cycles[-1]]

    @property
    def effects(self) -> BodyEffects:
        """What the finite bodies add to half-planes."""
        assert self.question.effects is not None  # for the type checker
        return self.question.effects

    @property
    def largest_half_width(self) -> float:
        """Largest contact half-width of half-planes in the last covered cycle [length]."""
        return float(np.max(self.path_of_half_planes.half_width[self.last_cycle]))

    @property
    def is_steady(self) -> bool:
        """Whether the last covered cycle ends in the state it started from."""
        return self.steady_from is not None and self.covered_cycles[-1] >= self.steady_from


def findings_with_effects(question: Question) -> Findings:
    """Answer of half-plane theory corrected for finite bodies: fields, displacements, friction work
    and their errors along the load path of a question.

    Parameters
    ----------
    question
        what is asked: the scene with its load path, the points, instants and fields that are
        wanted, and the effects of the finite bodies

    Returns
    -------
    Findings
        values by name, with errors, notes and checks of the laws of contact

    Raises
    ------
    InputError
        For scenes with bulk stress, tilt or unequal sides of the profile, and for straight steps;
        for curvatures under which the contact would split or leave the profile; for a path of more
        than 200,000 instants.
    """
    # InputError for scenes that are not symmetric.
    _require_symmetric(question)
    with histories_kept():  # exact half-plane theory follows the path once
        return _findings_of_symmetric_scene(question)


def _findings_of_symmetric_scene(question: Question) -> Findings:
    """Corrected half-plane answer to a question with a symmetric profile.

    The load path is followed with the finite bodies and with half-planes, by equal straight steps.
    Fields are those with the bodies. Tilt and bulk strain of the bodies move the edges of contact
    and stick. The friction work is that of exact half-plane theory, plus the difference between the
    two followed paths, plus what tilt and strain add.

    The dissipation is measured over the last cycle of the answer. Errors that are 0 are left out.
    """
    stop_watch = StopWatch("history", "fields", "dissipation")
    # the path, followed twice; `paths.path_rows` are the ends of the steps
    paths = _followed_paths(question)
    path_with_bodies = paths.path_with_bodies
    stop_watch.add_lap("history")

    # points: those asked for, or 200 across the widest contact and 5 % beyond
    x = question.x
    if x is None:
        x = mirrored_points(1.05 * float(np.max(path_with_bodies.half_width)))
    # `last_cycle`: rows of the last cycle of the answer; row_numbers: row nearest to each instant
    time, row_numbers = instants_and_row_numbers(question, paths.path_rows, paths.last_cycle)
    fields = FieldsByDistance.of_question(question, path_with_bodies, x, row_numbers)
    # what tilt and bulk strain do
    part_by_tilt_and_strain = _part_by_tilt_and_strain(paths)
    values_over_time = _values_with_moved_edges(paths, part_by_tilt_and_strain, row_numbers)
    stop_watch.add_lap("fields")

    # friction work of the cycles, W(x), and errors by the name of the value
    friction_work = _works_and_density(
        paths, fields.point_fields, fields.distance, part_by_tilt_and_strain
    )
    errors = friction_work.errors | _errors_of_steps(paths) | _errors_of_contact(paths)
    termination, message = _termination_and_message(paths)
    stop_watch.add_lap("dissipation")
    return Findings(
        time=time,
        x=x,
        values={
            **values_over_time,
            **fields.by_name,
            **friction_work.by_name(fields),
            "permanent_stick_half_width": _permanent_stick_with_bodies(
                paths, part_by_tilt_and_strain
            ),
            # a cycle that is followed but not in the answer is none of its steady ones
            "steady_from": paths.steady_from if paths.is_steady else None,
        },
        termination=termination,
        message=message,
        notes=tuple(_notes_of(paths, part_by_tilt_and_strain)),
        errors={name: error for name, error in errors.items() if error},
        certificates=admissibility_checks_of(path_with_bodies, fields.at_distances, row_numbers),
        counts={
            "points_evaluated": len(fields.distance),
            **path_with_bodies.counts,
            "cycles_solved": len(paths.path_rows.cycles),
        },
        seconds=stop_watch.seconds,
    )


class FieldsByDistance(NamedTuple):
    """Fields of an answer at n instants by the distance |x| of its m points from the middle of
    contact. All are even or odd in x, so that each |x| is evaluated once.

    Attributes
    ----------
    distance, distance_index
        (k,) different |x| [length]; (m,) for each point the index of its own among them
    point_fields
        evaluates fields at these distances along the followed path
    at_distances
        pressure, shear [stress], slip [length] and state, (n, k) each, by name
    """

    distance: Array
    distance_index: Indices
    point_fields: PointFields
    at_distances: dict[str, NDArray[Any]]

    @classmethod
    def of_question(
        cls, question: Question, path_with_bodies: PathSeries, x: Array, row_numbers: Indices
    ) -> FieldsByDistance:
        """Fields at points x (m,) [length] along a followed path, at its rows with these numbers,
        (n,). A field that the question does not want is NaN, a state that it does not want is open.
        """
        distance, distance_index = distances_and_indices(x)
        point_fields = PointFields(path_with_bodies, distance)
        fields = fields_at(question, point_fields, distance, row_numbers)
        return cls(distance, distance_index, point_fields, fields)

    @property
    def by_name(self) -> dict[str, NDArray[Any]]:
        """The fields at the m points, (n, m) each, by their names in a solution."""
        return {name: self.at_points(field) for name, field in self.at_distances.items()}

    def at_points(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values at the distances, (k,) or (n, k), as values at the m points, (m,) or (n, m)."""
        return np.take(values, self.distance_index, axis=-1)


def _values_with_moved_edges(
    paths: _Paths, part_by_tilt_and_strain: TiltAndStrainPart, row_numbers: Indices
) -> dict[str, Array]:
    """Loads, displacements, half-widths (n,) and edges (n, 2) at the rows with these numbers, by
    their names in a solution. Tilt and bulk strain of the bodies move the edges of contact and
    stick.
    """
    values_over_time = values_over_time_at(paths.question, paths.path_with_bodies, row_numbers)
    contact_centres, stick_centres = part_by_tilt_and_strain.centres(paths.path_rows.time)
    for name, centres in (("contact_edges", contact_centres), ("stick_edges", stick_centres)):
        values_over_time[name] = values_over_time[name] + centres[row_numbers, None]
    return values_over_time


def _permanent_stick_with_bodies(
    paths: _Paths, part_by_tilt_and_strain: TiltAndStrainPart
) -> float:
    """Half-width of the permanent stick zone of the last cycle [length]; NaN where no point sticks
    throughout. Tilt and bulk strain of the bodies move the stick zone during the cycle, which may
    narrow the permanent one.
    """
    _, stick_centres = part_by_tilt_and_strain.centres(paths.path_rows.time)
    return permanent_stick_half_width(
        paths.path_with_bodies, paths.last_cycle, stick_centres[paths.last_cycle]
    )


def _followed_paths(question: Question) -> _Paths:
    """Friction memory along the load path of a question, by equal straight steps twice: with the
    curvatures of the finite bodies, and with half-planes.

    The steps are those of half-plane theory, with the turning points of slip under the bodies.
    """
    scene = question.scene
    effects = question.effects
    assert effects is not None  # for the type checker
    # Exact half-plane theory, without the effects, along the path of the scene.
    solved_path = path_of_question(replace(question, effects=None), None)
    exact_path = _HalfPlanePath(scene, solved_path)
    path_rows = exact_path.first_rows(question.time)
    modulus = composite_modulus(scene.material)
    contact = contact_of(scene.profile, scene.material)
    curvatures_per_load = curvatures_of(effects)

    # Flat punches that make up the contact, with the loads that they carry.
    punch_table = punch_table_of(contact, modulus, path_rows, curvatures_per_load)
    friction_coefficient = scene.friction.coefficient
    # G of the widest punch: load that presses a parabola x^2/2 into contact up to there.
    largest_parabola_load = float(punch_table.parabola_load(punch_table.largest_s))
    path_rows = exact_path.rows_with_turning_points(
        path_rows, friction_coefficient, curvatures_per_load, largest_parabola_load
    )

    # `follow` gives friction memory and slip zones at the rows.
    normal_and_tangential_loads = (path_rows.normal_load, path_rows.tangential_load)
    # Curvatures(): all zero.
    memory_of_half_planes = follow(
        punch_table, friction_coefficient, *normal_and_tangential_loads, Curvatures()
    )

    # Half-planes are given only for an estimate of q_2, the second moment of the shear, by which
    # the fourth-order term T_22 changes the curvature of the faces.
    memory_of_bodies = follow(
        punch_table,
        friction_coefficient,
        *normal_and_tangential_loads,
        curvatures_per_load,
        memory_of_half_planes,
    )
    steady_from = _first_steady_cycle(memory_of_bodies, path_rows)
    return _Paths(
        question=question,
        path_rows=path_rows,
        path_with_bodies=PathSeries(memory_of_bodies, contact, modulus, effects),
        path_of_half_planes=PathSeries(memory_of_half_planes, contact, modulus, None),
        steady_from=steady_from,
        covered_cycles=_covered_cycles(question, exact_path, steady_from),
    )


def _require_symmetric(question: Question) -> None:
    """Refuse what corrected half-plane theory does not cover: InputError for bulk stress, tilt,
    unequal sides of the profile, and steps that are straight between given rows.
    """
    if question.scene.unsymmetric:
        raise InputError(
            "effects: corrected theory takes neither bulk stress nor tilt nor a profile with"
            " unequal sides; leave effects out, or take halfplane_fe.solve"
        )
    if question.straight_steps:
        raise InputError(
            "straight_steps: corrected theory takes the scene's own path; leave straight_steps out,"
            " or effects"
        )


def punch_table_of(
    contact: SymmetricContact, modulus: float, path_rows: PathRows, curvatures: Curvatures
) -> PunchTable:
    """Table of the flat punches that make up the contact, wide enough for every instant of a load
    path, with the curvatures of finite bodies and without.

    A negative curvature of the gap widens the contact. The table is widened until its punches carry
    P at every instant: eta + kn G + n4 G_4 >= P at its end. eta, G and G_4 are the loads that press
    the profile, x^2/2 and x^4/24 into contact up to there; kn and n4 are factors of the latter two
    in the gap.

    Parameters
    ----------
    contact
        P(a) of the profile on half-planes
    modulus
        E* [stress]
    path_rows
        instants of the path with P and Q
    curvatures
        what P and Q add to the curvature of gap and faces

    Raises
    ------
    InputError
        Where that contact is wider than the profile, or where the bodies bend the faces away from
        each other so that the contact would split.
    """
    # Half-width that the table covers: at first that of half-planes at the largest P. Then kn
    # without p_2, and n4, at each instant.
    covered_half_width = float(contact.half_width(float(np.max(path_rows.normal_load))))
    gap_curvature = curvatures.gap_curvature_under(path_rows.normal_load, path_rows.tangential_load)
    gap_fourth_coefficient = curvatures.normal_fourth * path_rows.normal_load

    # _MOST_WIDENINGS: 60, each by _TABLE_WIDTH_FACTOR = 1.02; extent: largest half-width of the
    # profile. largest_s: coordinate s of the widest punch of the table.
    for _ in range(_MOST_WIDENINGS):
        punch_table = PunchTable(
            contact, modulus, min(covered_half_width * _TABLE_WIDTH_FACTOR, contact.extent)
        )
        # The second moment p_2 of the pressure is at most that of a flat punch, P c^2/2.
        # normal_mixed: N_22, by which p_2 adds 2 N_22 p_2 to kn.
        largest_moment = (
            path_rows.normal_load * float(punch_table.half_width(punch_table.largest_s)) ** 2 / 2
        )
        lower_bound_of_curvature = (
            gap_curvature + 2 * min(curvatures.normal_mixed, 0.0) * largest_moment
        )
        # Load that the punches up to the widest carry, with the least kn that is possible.
        load_at_table_end = float(
            punch_table.profile_load(punch_table.largest_s)
        ) + lower_bound_of_curvature * float(punch_table.parabola_load(punch_table.largest_s))
        load_at_table_end = load_at_table_end + gap_fourth_coefficient * float(
            punch_table.fourth_load(punch_table.largest_s)
        )
        if np.all(load_at_table_end >= path_rows.normal_load):
            break
        if covered_half_width >= contact.extent:
            raise InputError(
                "profile: with the curvature of the bodies the contact is wider than the profile,"
                f" {contact.extent:.6g}: state a wider profile or smaller loads"
            )
        covered_half_width *= _TABLE_WIDTH_FACTOR
    else:
        raise contact_splits_error()
    _require_one_contact(
        punch_table, contact, gap_curvature, lower_bound_of_curvature, gap_fourth_coefficient
    )
    return punch_table


def _require_one_contact(
    punch_table: PunchTable,
    contact: SymmetricContact,
    gap_curvature: Array,
    lower_bound_of_curvature: Array,
    gap_fourth_coefficient: Array,
) -> None:
    """Refuse curvatures of finite bodies under which the contact would split, by InputError.

    It does not split if the load up to each half-width c, eta + kn G + n4 G_4, grows with c. This
    is checked at the instants of the least kn and of the least n4.

    Parameters
    ----------
    punch_table
        eta, G and G_4 by the coordinate s of a half-width c
    contact
        the profile, whose flat has no punches inside
    gap_curvature, lower_bound_of_curvature
        kn (n,) without the part by the second moment of the pressure, and a lower bound of kn
    gap_fourth_coefficient
        n4 (n,)

    # notation: eta, G, G_4 loads that press the profile, x^2/2 and x^4/24 into contact up to the
    #           half-width c; kn, n4 factors of x^2/2 and x^4/24 that the bodies add to the gap at
    #           each of n instants
    """
    # s: coordinate of the punches in the table; the punches within the flat carry no load.
    first_s = 1.0 if contact.least_half_width else 0.0
    # _PUNCHES_CHECKED: 200 punches.
    s = np.linspace(first_s, punch_table.largest_s, _PUNCHES_CHECKED)
    profile_load = punch_table.profile_load(s)
    parabola_load = punch_table.parabola_load(s)
    fourth_load = punch_table.fourth_load(s)
    least_known_curvature = min(float(np.min(gap_curvature)), 0.0)
    if np.any(np.diff(profile_load + least_known_curvature * parabola_load) < 0):
        raise contact_splits_error()
    # Where kn or n4 is least.
    for row in {int(np.argmin(lower_bound_of_curvature)), int(np.argmin(gap_fourth_coefficient))}:
        carried_load = profile_load + lower_bound_of_curvature[row] * parabola_load
        carried_load = carried_load + gap_fourth_coefficient[row] * fourth_load
        if np.any(np.diff(carried_load) < 0):
            raise contact_splits_error()


def contact_splits_error() -> InputError:
    """Error where bodies bend the faces away from each other, so that the contact would split."""
    return InputError(
        "effects: the normal curvature is negative and larger than that of the profile: by it alone"
        " the contact would split, which corrected theory does not take"
    )


def _first_steady_cycle(followed_path: FollowedPath, path_rows: PathRows) -> int | None:
    """Index of the first cycle, 0 or 1, that ends in the friction state it started from; None where
    neither does. A path without cycles counts as steady (0) if it ends unloaded.

    `followed_path` holds the friction state at each instant. `path_rows` has the instants with
    their loads; its `end_rows` are those at which the initial loading and each cycle end.
    """
    if path_rows.period is None:
        return 0 if path_rows.normal_load[-1] <= 0 else None
    return followed_path.first_steady_cycle(path_rows.end_rows)


def _covered_cycles(
    question: Question, half_plane_path: _HalfPlanePath, steady_from: int | None
) -> tuple[int, ...]:
    """For each whole cycle of the answer, the index of the followed cycle that it equals.

    Only two cycles are followed: index 0 or 1. Later cycles are taken to equal the second. For a
    path that does not repeat it is (0,).

    Parameters
    ----------
    question
        scene with its number of `cycles`, and the instants `time`, None if none are asked for
    half_plane_path
        load path with the ends of its cycles, `cycle_ends`, and its `period`, None if it does not
        repeat
    steady_from
        index of the first cycle that repeats; None where none was seen to
    """
    if half_plane_path.period is None:
        return (0,)
    n_cycles_of_scene = question.scene.cycles
    n_cycles_to_steady_state = 2 if steady_from is None else steady_from + 1
    # Whole cycles up to the last of the instants; 0 without instants or within the first cycle.
    _, n_whole_cycles = cycles_to_follow(
        half_plane_path.cycle_ends[0], half_plane_path.period, n_cycles_of_scene, question.time
    )
    # Without whole cycles at given instants: those of the scene, up to the first steady one.
    n_cycles = n_whole_cycles or min(n_cycles_of_scene, n_cycles_to_steady_state)
    followed_cycles = tuple(min(cycle, 1) for cycle in range(n_cycles))
    if question.wants_last_cycle_alone:
        return followed_cycles[-1:]
    return followed_cycles


def instants_and_row_numbers(
    question: Question, path_rows: PathRows, last_cycle: slice
) -> tuple[Array, Indices]:
    """Instants of the answer, (n,), and the number of the followed instant nearest to each, (n,).

    The instants are those of the question. Where it gives none, they are the followed instants up
    to the end of the last cycle of the answer. If only that cycle is wanted, they are its instants.

    Parameters
    ----------
    question
        instants `time` that are asked for, None if none are; whether only the last cycle is wanted
    path_rows
        the followed instants, `time` (r,), and the `period` of the path
    last_cycle
        rows of the last cycle of the answer; the path may be followed beyond it
    """
    if question.time is None:
        first_row = last_cycle.start if question.wants_last_cycle_alone else 0
        row_numbers = np.arange(first_row, last_cycle.stop)
        return path_rows.time[row_numbers], row_numbers
    # Later instants go back by whole periods to the followed part of the path.
    time_in_path, _ = time_in_followed_path(
        question.time, float(path_rows.time[0]), float(path_rows.time[-1]), path_rows.period
    )
    row_after = np.clip(np.searchsorted(path_rows.time, time_in_path), 1, len(path_rows.time) - 1)
    # The nearer of the rows before and after each instant.
    time_since_row = time_in_path - path_rows.time[row_after - 1]
    row_before_is_nearer = time_since_row < path_rows.time[row_after] - time_in_path
    return question.time, row_after - row_before_is_nearer


def values_over_time_at(
    question: Question, path_with_bodies: PathSeries, row_numbers: Indices
) -> dict[str, Array]:
    """Values of the answer that have one number per instant, or one per edge, by their names.

    They are loads, displacements, contact and stick half-width (n,) and the edges (n, 2), left then
    right. Displacements that were not asked for are NaN.

    Parameters
    ----------
    question
        which displacements are wanted
    path_with_bodies
        the followed path with the finite bodies
    row_numbers
        (n,) numbers of its instants
    """
    not_a_number = np.full(len(row_numbers), np.nan)
    tangential_displacement = not_a_number
    normal_approach = not_a_number
    if question.wants("tangential_displacement"):
        tangential_displacement = path_with_bodies.tangential_displacement[row_numbers]
    if question.wants("normal_approach"):
        normal_approach = path_with_bodies.normal_approach[row_numbers]
    half_width = path_with_bodies.half_width[row_numbers]
    stick_half_width = path_with_bodies.stick_half_width[row_numbers]
    signs_of_sides = np.array([-1.0, 1.0])
    return {
        "normal_load": path_with_bodies.followed_path.normal_load[row_numbers],
        "tangential_load": path_with_bodies.followed_path.tangential_load[row_numbers],
        "tangential_displacement": tangential_displacement,
        "normal_approach": normal_approach,
        "contact_half_width": half_width,
        "stick_half_width": stick_half_width,
        "contact_edges": half_width[:, None] * signs_of_sides,
        "stick_edges": stick_half_width[:, None] * signs_of_sides,
    }


def fields_at(
    question: Question, point_fields: PointFields, distance: Array, row_numbers: Indices
) -> dict[str, NDArray[Any]]:
    """Fields of the answer at instants and points, by their names, (n, k) each: pressure and shear
    [stress], slip [length] and state of contact.

    A field that was not asked for is NaN everywhere, the state then OPEN.

    Parameters
    ----------
    question
        which fields are wanted
    point_fields
        fields at `distance` along the followed path, the load path with its memory of friction
    distance
        (k,) |x| [length] from the middle of contact
    row_numbers
        (n,) numbers of the instants of that path

    Raises
    ------
    InputError
        Where the pressure is asked for and negative somewhere: the contact would split.
    """
    shape = (len(row_numbers), len(distance))
    fields: dict[str, NDArray[Any]] = {
        name: np.broadcast_to(np.nan, shape) for name in ("pressure", "shear", "slip")
    }
    fields["state"] = np.broadcast_to(np.int8(OPEN), shape)
    if question.wants("pressure"):
        fields["pressure"] = point_fields.pressure(row_numbers)
        if np.any(fields["pressure"] < 0):
            raise contact_splits_error()
    if question.wants("shear"):
        fields["shear"] = point_fields.shear(row_numbers)
    if question.wants("slip"):
        fields["slip"] = point_fields.slip(row_numbers)
    if question.wants("state"):
        fields["state"] = _states(point_fields, distance, row_numbers)
    return fields


def _states(point_fields: PointFields, distance: Array, row_numbers: Indices) -> NDArray[np.int8]:
    """State of contact of each point at each instant, (n, k): open, stick, forward or reverse slip.

    A point slips in the zone at the edge of contact, or in an inner zone of the memory curve. That
    curve is the locked-in tangential force of the flat punches up to each half-width. An inner zone
    may slip the other way, or while the edge sticks. At instants at which |q| of that curve would
    exceed f p, the inner zone is that of the extra slip instead.

    Parameters
    ----------
    point_fields
        fields of the followed path at `distance`
    distance
        (k,) |x| [length] from the middle
    row_numbers
        (n,) numbers of the instants
    """
    path_with_bodies = point_fields.series
    followed_path = path_with_bodies.followed_path
    signs_of_sides = np.array([-1.0, 1.0])
    states_without_inner_zone = _states_by_edge_zone(followed_path, distance, row_numbers)

    # the inner zone, if there is one: its ends as coordinates s of half-widths in the table of flat
    # punches, and its direction of slip, 0 without one
    inner_zone_ends = followed_path.table.half_width(followed_path.inner_zone_s[row_numbers])
    state_in_inner_zone = _STATES_BY_DIRECTION[
        followed_path.inner_zone_direction[row_numbers, None] + 1
    ]
    is_in_inner_zone = (distance > inner_zone_ends[:, [0]]) & (distance < inner_zone_ends[:, [1]])
    states = np.where(is_in_inner_zone, state_in_inner_zone, states_without_inner_zone)

    # At these instants points inside the contact slip further than by the memory curve.
    for index, extra_slip in point_fields.inner_slips(row_numbers):
        state_of_extra_slip = _STATES_BY_DIRECTION[extra_slip.direction + 1]
        # is_slipping (k,): whether a point slips further
        states[index] = np.where(
            extra_slip.is_slipping, state_of_extra_slip, states_without_inner_zone[index]
        )
    contact_half_width = path_with_bodies.half_width[row_numbers, None]
    is_pressed = followed_path.normal_load[row_numbers, None] > 0
    is_in_contact = is_between_edges(contact_half_width * signs_of_sides, distance) & is_pressed
    return np.where(is_in_contact, states, np.int8(OPEN))


# By the direction of slip, -1, 0 or +1, plus 1.
_STATES_BY_DIRECTION = np.array((SLIP_REVERSE, STICK, SLIP_FORWARD), dtype=np.int8)


def _states_by_edge_zone(
    followed_path: FollowedPath, distance: Array, row_numbers: Indices
) -> NDArray[np.int8]:
    """State of each point at |x| = `distance` (k,) at the rows of a followed path with these
    numbers, (n, k). It follows from the slip zone at the edge of contact alone.

    All points are taken as in contact. Within the stick edges they stick. Elsewhere they slip
    forward or in reverse as the edge does, or stick where the edge sticks. `direction` of the path
    is that of slip at the edge, 0 where it sticks.
    """
    signs_of_sides = np.array([-1.0, 1.0])
    # stick_edge_s: coordinate s of the stick edge in the table of flat punches
    stick_half_width = followed_path.table.half_width(followed_path.stick_edge_s[row_numbers])[
        :, None
    ]
    state_of_slip_zone = _STATES_BY_DIRECTION[followed_path.direction[row_numbers, None] + 1]
    # In full slip the stick zone ends at 0: only x = 0 is within it, and that point slips.
    is_within_stick_edges = is_between_edges(stick_half_width * signs_of_sides, distance) & (
        stick_half_width > 0
    )
    return np.where(is_within_stick_edges, np.int8(STICK), state_of_slip_zone)


class _WorkOfAnswer(NamedTuple):
    """Friction work of an answer. NaN where a value is not wanted or not known.

    Attributes
    ----------
    work_of_cycles
        (c,) of the cycles of the answer [energy per thickness]
    loop_work
        work of the loads in the last cycle, closed-int Q dU + P d(approach) [energy per thickness]
    density
        (k,) W(x), friction work per area of the last cycle at the distances |x|
    errors
        relative, by the names of the values
    """

    work_of_cycles: Array
    loop_work: float
    density: Array
    errors: dict[str, float]

    def by_name(self, fields: FieldsByDistance) -> dict[str, float | Array]:
        """The works and W(x) by their names in a solution. W(x) is given at the m points of the
        answer, (m,), which `fields` has by their distance.
        """
        return {
            "dissipation": float(self.work_of_cycles[-1]),
            "loop_work": self.loop_work,
            "cycle_dissipation": self.work_of_cycles,
            "dissipation_density": fields.at_points(self.density),
        }


def _works_and_density(
    paths: _Paths,
    point_fields: PointFields,
    distance: Array,
    part_by_tilt_and_strain: TiltAndStrainPart,
) -> _WorkOfAnswer:
    """Friction work of the cycles of the answer, its density W(x), and their relative errors.

    Each is that of exact half-plane theory plus a difference: the path with the finite bodies minus
    the path of half-planes, both by equal straight steps. The errors of the steps cancel in it.

    Parameters
    ----------
    paths
        load path with the bodies and with half-planes, by equal steps; the question with its wanted
        fields; `covered_cycles`: for each cycle of the answer the index of the followed cycle that
        it equals
    point_fields
        fields along the path with the bodies at `distance`
    distance
        (k,) |x| [length] from the middle
    part_by_tilt_and_strain
        work that tilt and bulk strain of the bodies add

    Returns
    -------
    _WorkOfAnswer
        NaN for what the question does not ask for
    """
    question = paths.question
    work_of_cycles = np.full(len(paths.covered_cycles), np.nan)
    loop_work = math.nan
    density = np.full(len(distance), np.nan)
    errors: dict[str, float] = {}
    # of dissipation and dissipation density, those that are asked for
    wanted_fields = question.fields & _FIELDS_OF_WORK
    if not wanted_fields:
        return _WorkOfAnswer(work_of_cycles, loop_work, density, errors)

    # at the ends of the initial loading and of each cycle
    end_times = paths.path_rows.time[list(paths.path_rows.end_rows)]
    exact_theory = _exact_theory(paths, wanted_fields, distance, end_times)
    if question.wants("dissipation"):
        # Theory stops at a steady cycle, which later ones equal.
        solved_works = np.asarray(exact_theory.values["cycle_dissipation"])
        exact_works = solved_works[np.minimum(paths.covered_cycles, len(solved_works) - 1)]
        # Also the work of the loads in the last cycle, int Q dU + P d(approach).
        work_of_cycles, loop_work, errors = _works_and_errors(
            paths, exact_works, part_by_tilt_and_strain
        )
        if "dissipation" in errors:
            errors["dissipation"] += exact_theory.errors.get("dissipation", 0.0)
    if question.wants("dissipation_density"):
        exact_density = np.asarray(exact_theory.values["dissipation_density"])
        density, density_error = _density_and_error(paths, point_fields, distance, exact_density)
        if density_error is not None:
            errors["dissipation_density"] = density_error
    return _WorkOfAnswer(work_of_cycles, loop_work, density, errors)


def _density_and_error(
    paths: _Paths, point_fields: PointFields, distance: Array, exact_density: Array
) -> tuple[Array, float | None]:
    """Friction work per area W(x) of the last cycle, (k,) [energy per area], and its error over the
    largest W(x), None where half-planes do not slip.

    It is `exact_density` of half-plane theory plus the change that finite bodies make, by equal
    steps with and without them; 0 where the bodies do not slip.

    Parameters
    ----------
    paths
        load path with the bodies and with half-planes, by equal steps; `last_cycle`: rows of the
        last cycle of the answer
    point_fields
        fields along the path with the bodies at `distance`
    distance
        (k,) |x| [length] from the middle
    exact_density
        (k,) W(x) of half-planes by exact theory
    """
    path_of_half_planes = paths.path_of_half_planes
    last_cycle = paths.last_cycle
    # W(x) of half-planes by steps, and of the bodies by the same steps.
    density_by_steps = PointFields(path_of_half_planes, distance).work_density(last_cycle)
    density_of_bodies = point_fields.work_density(last_cycle)
    density = np.maximum(exact_density + density_of_bodies - density_by_steps, 0.0)
    density = np.where(density_of_bodies > 0, density, 0.0)
    largest_density = float(np.max(exact_density, initial=0.0))
    if not largest_density > 0:
        return density, None
    # By the steps, relative to the largest W(x); then what the bodies leave uncertain of W.
    step_error = float(np.max(np.abs(density_by_steps - exact_density))) / largest_density
    if not path_of_half_planes.work(last_cycle) > 0:  # no friction work, nothing to be relative to
        return density, step_error
    return density, step_error + work_uncertainty_by_bodies(
        paths.path_with_bodies, path_of_half_planes, last_cycle, paths.effects
    )


def _works_and_errors(
    paths: _Paths, exact_works: Array, part_by_tilt_and_strain: TiltAndStrainPart
) -> tuple[Array, float, dict[str, float]]:
    """Friction work of each cycle of the answer (c,), the work of the loads in the last cycle, and
    the relative errors of both by name.

    Friction work is that of half-planes plus what curvatures, tilt and bulk strain of finite bodies
    change. The work of the loads is the closed integral of Q dU + P d(approach). It equals the
    friction work where the cycle is steady, and is NaN where it cannot be compared or is not asked
    for. There are no errors where half-planes do no work. The error of the friction work is NaN
    where tilt and strain are left out.

    Parameters
    ----------
    paths
        load path with the bodies and with half-planes, by equal steps; `covered_cycles`: for each
        of the c cycles of the answer the index of the followed cycle that it equals
    exact_works
        (c,) work of these cycles by exact half-plane theory [energy per thickness]
    part_by_tilt_and_strain
        work that tilt and bulk strain add, or why it is left out
    """
    # Rows of each cycle of the answer in the followed path.
    rows_of_cycles = [paths.path_rows.cycles[cycle] for cycle in paths.covered_cycles]
    works_of_half_planes = np.array(
        [paths.path_of_half_planes.work(rows) for rows in rows_of_cycles]
    )
    works_of_bodies = np.array([paths.path_with_bodies.work(rows) for rows in rows_of_cycles])
    works_of_tilt_and_strain = [
        part_by_tilt_and_strain.work(cycle) for cycle in paths.covered_cycles
    ]

    # Both paths by the same steps: their errors nearly cancel.
    friction_works = exact_works + (works_of_bodies - works_of_half_planes)
    friction_works = friction_works + np.array(
        [added_work.value for added_work in works_of_tilt_and_strain]
    )
    # The displacements lack what tilt and bulk strain do to slip: no comparison with them.
    has_loop_work = (
        paths.question.wants("loop_work")
        and not part_by_tilt_and_strain.has_work
        and paths.is_steady
        and paths.path_rows.period is not None
    )
    loop_work = math.nan
    if has_loop_work:
        loop_work = paths.path_with_bodies.loop_work(paths.last_cycle)
    exact_last_work = float(exact_works[-1])
    if exact_last_work <= 0:
        return friction_works, loop_work, {}
    errors = _errors_of_last_work(
        paths, exact_last_work, works_of_tilt_and_strain[-1].uncertainty, has_loop_work
    )
    if part_by_tilt_and_strain.left_out:
        errors["dissipation"] = math.nan  # how much tilt and strain add is not known
    return friction_works, loop_work, errors


def _errors_of_last_work(
    paths: _Paths,
    exact_work: float,
    uncertainty_of_tilt_and_strain: float,
    has_loop_work: bool,
) -> dict[str, float]:
    """Relative errors of the friction work of the last cycle, "dissipation", and of the work of the
    loads in it, "loop_work", where there is one.

    Each is divided by `exact_work` > 0, the work by exact half-plane theory [energy per thickness].
    That of the friction work is the sum of:

    - half the error of the work of half-planes by the same steps;
    - twice the change of the work with bodies when long steps are halved;
    - what the uncertain curvatures of the bodies and their next order leave uncertain;
    - the uncertainty of the work that tilt and bulk strain add.
    """
    path_of_half_planes = paths.path_of_half_planes
    last_cycle = paths.last_cycle
    work_by_steps = float(path_of_half_planes.work(last_cycle))
    step_error = _FACTOR_ON_STEP_ERROR * abs(work_by_steps / exact_work - 1)
    change_by_halving = abs(
        _work_of_halved_steps(paths) - float(paths.path_with_bodies.work(last_cycle))
    )
    step_error += _FACTOR_ON_HALVING * change_by_halving / exact_work
    uncertainty_by_bodies = work_uncertainty_by_bodies(
        paths.path_with_bodies, path_of_half_planes, last_cycle, paths.effects
    )
    errors = {
        "dissipation": step_error
        + uncertainty_of_tilt_and_strain / exact_work
        + uncertainty_by_bodies
    }
    if has_loop_work:
        loop_work_of_half_planes = path_of_half_planes.loop_work(last_cycle)
        errors["loop_work"] = abs(loop_work_of_half_planes / exact_work - 1) + uncertainty_by_bodies
    return errors


def work_uncertainty_by_bodies(
    path_with_bodies: PathSeries,
    path_of_half_planes: PathSeries,
    cycle_rows: slice,
    effects: BodyEffects,
) -> float:
    """Uncertainty of the friction work of a cycle that the effects of finite bodies leave, relative
    to the work of half-planes; at least 3e-5.

    The curvatures of the bodies are uncertain themselves, and their series in x ends after the
    fourth order. A fraction of any change of work by the curvatures is therefore uncertain. There
    is a fraction for each of two kinds: curvatures that follow P and curvatures that follow Q. The
    two kinds may cancel each other in the friction work. Where they may, each kind is followed
    alone, and its own change counts.

    Parameters
    ----------
    path_with_bodies, path_of_half_planes
        the path followed with the finite bodies, and with half-planes
    cycle_rows
        instants of the cycle, in which half-planes must do friction work
    effects
        curvatures of the bodies
    """
    # By kind of curvature, for the largest half-width of the cycle.
    uncertain_fractions = uncertain_fraction_of_curvatures(
        effects, float(np.max(path_of_half_planes.half_width[cycle_rows]))
    )
    work_of_half_planes = path_of_half_planes.work(cycle_rows)
    change_by_bodies = path_with_bodies.work(cycle_rows) / work_of_half_planes - 1
    curvatures_per_load = curvatures_of(effects)

    # are_of_mirrored_bodies: no gap curvature under Q and no face curvature under P. normal: N, gap
    # under P; tangential: T, faces under Q.
    if (
        curvatures_per_load.are_of_mirrored_bodies
        and curvatures_per_load.normal >= 0
        and curvatures_per_load.tangential >= 0
    ):
        # Both kinds change the work in one direction: nothing cancels.
        # LEAST_UNCERTAIN_FRACTION: 3e-5.
        return abs(change_by_bodies) * max(uncertain_fractions.values()) + LEAST_UNCERTAIN_FRACTION
    followed_path_of_bodies = path_with_bodies.followed_path
    normal_and_tangential_loads = (
        followed_path_of_bodies.normal_load,
        followed_path_of_bodies.tangential_load,
    )
    uncertainty = LEAST_UNCERTAIN_FRACTION

    # What the bodies change beyond the sum of the changes by each kind alone.
    change_by_interaction = change_by_bodies
    # CURVATURES: names of the two kinds. `follow` gives the friction memory along the same path;
    # its step_work is that of the step that ends at each row, without the factor A/pi.
    for kind_of_curvature in CURVATURES:
        curvatures_of_kind = curvatures_of(with_one_group_alone(effects, kind_of_curvature))
        path_by_kind = follow(
            followed_path_of_bodies.table,
            followed_path_of_bodies.friction,
            *normal_and_tangential_loads,
            curvatures_of_kind,
            path_of_half_planes.followed_path,
        )
        work_by_kind = path_with_bodies.unit_compliance * float(
            np.sum(path_by_kind.step_work[cycle_rows][1:])
        )
        change_by_kind = work_by_kind / work_of_half_planes - 1
        uncertainty += abs(change_by_kind) * uncertain_fractions[kind_of_curvature]
        change_by_interaction -= change_by_kind
    return uncertainty + abs(change_by_interaction) * sum(uncertain_fractions.values())


def _errors_of_contact(paths: _Paths) -> dict[str, float]:
    """Relative uncertainty that the effects of finite bodies leave in the largest pressure and in
    the contact half-width, keyed "pressure" and "contact_half_width". Empty where there is no
    contact.

    The curvatures of the bodies are uncertain themselves, and their series in x ends after the
    fourth order. So a fraction of what they change is uncertain. The change is the ratio of values
    with and without them, minus 1, at the largest load of the last cycle. 3e-5 of the value is
    added.

    Parameters
    ----------
    paths
        load path with the bodies and with half-planes; `last_cycle`: rows of the last cycle
    """
    path_with_bodies = paths.path_with_bodies
    path_of_half_planes = paths.path_of_half_planes
    last_cycle = paths.last_cycle
    largest_half_width = float(np.max(path_of_half_planes.half_width[last_cycle]))
    if not largest_half_width > 0:
        return {}
    # Instant of the largest P, and places at which its largest pressure is sought.
    row_of_largest_load = last_cycle.start + int(
        np.argmax(path_with_bodies.followed_path.normal_load[last_cycle])
    )
    # _PLACES_CHECKED: 100 places.
    places = largest_half_width * np.sin(np.linspace(0.0, math.pi / 2, _PLACES_CHECKED))
    pressure_of_bodies, pressure_of_half_planes = (
        float(np.max(PointFields(path_series, places).pressure(np.array([row_of_largest_load]))))
        for path_series in (path_with_bodies, path_of_half_planes)
    )
    pressure_change = 0.0
    if pressure_of_half_planes:
        pressure_change = abs(pressure_of_bodies / pressure_of_half_planes - 1)
    half_width_ratio = (
        path_with_bodies.half_width[row_of_largest_load]
        / path_of_half_planes.half_width[row_of_largest_load]
    )
    half_width_change = abs(float(half_width_ratio) - 1)
    # The larger of the fractions of curvatures that follow P and of those that follow Q.
    fractions_of_loads = uncertain_fraction_of_curvatures(paths.effects, largest_half_width)
    uncertain_fraction = max(fractions_of_loads.values())
    return {
        "pressure": pressure_change * uncertain_fraction + LEAST_UNCERTAIN_FRACTION,
        "contact_half_width": half_width_change * uncertain_fraction + LEAST_UNCERTAIN_FRACTION,
    }


def _work_of_halved_steps(paths: _Paths) -> float:
    """Friction work of the last cycle with finite bodies [energy per thickness], with some of the
    straight steps halved: the long ones in which the contact grows in stick.

    In such a step the memory curve (locked-in tangential force of the flat punches up to each
    half-width) grows by a straight chord, which is an approximation. All other steps are exact
    however long they are. Long is a step in which P grows by more than 1 % of its largest value.

    Parameters
    ----------
    paths
        load path followed with the bodies; `last_cycle`: rows of the last cycle of the answer
    """
    followed_path = paths.path_with_bodies.followed_path
    n_rows = len(followed_path.normal_load)

    # edge_s: coordinate of the edge of contact, grows with it; direction: of slip at the edge in
    # the step that ends at the row, 0 where it sticks.
    grows_in_stick = (np.diff(followed_path.edge_s) > 0) & (followed_path.direction[1:] == 0)
    load_growth = np.diff(followed_path.normal_load) / np.max(followed_path.normal_load)
    long_chords = np.flatnonzero(grows_in_stick & (load_growth > _SHORT_CHORD_LOAD_SHARE))
    if not len(long_chords):
        return paths.path_with_bodies.work(paths.last_cycle)

    # Whole numbers are rows, halves are the middles of steps.
    row_numbers = np.union1d(np.arange(n_rows), long_chords + 0.5)
    # The same path again, with the additional rows in the middle of long chords.
    memory_of_halved_steps = follow(
        followed_path.table,
        followed_path.friction,
        np.interp(row_numbers, np.arange(n_rows), followed_path.normal_load),
        np.interp(row_numbers, np.arange(n_rows), followed_path.tangential_load),
        curvatures_of(paths.effects),
    )

    # The first row of a cycle ends a step before it. step_work: of the step that ends at each row,
    # without the factor A/pi.
    first_row, row_after_last, _ = paths.last_cycle.indices(n_rows)
    is_in_cycle = (row_numbers > first_row) & (row_numbers <= row_after_last - 1)
    return paths.path_with_bodies.unit_compliance * float(
        np.sum(memory_of_halved_steps.step_work[is_in_cycle])
    )


def _part_by_tilt_and_strain(paths: _Paths) -> TiltAndStrainPart:
    """Friction work and shift of the edges that tilt and bulk strain of the finite bodies cause.
    The uncertainty of that work includes what the curvatures of the bodies leave uncertain.

    Both are taken to the second order in tilt and strain. Where that does not hold, the work alone
    is found by a numerical solution on grids, if the question asks for it. Where neither is
    possible, the reason is returned instead of a number. For bodies without tilt and strain the
    part is empty.

    Parameters
    ----------
    paths
        load path followed with the bodies and with half-planes; `last_cycle`: rows of the last
        cycle of the answer; the question with its scene and effects
    """
    question = paths.question
    effects = paths.effects
    # TILT_AND_STRAIN_NAMES: attributes of `effects` with tilt and strain per P and per Q.
    if not any(getattr(effects, name).value for name in TILT_AND_STRAIN_NAMES):
        return TiltAndStrainPart()
    try:
        part_by_tilt_and_strain = TiltAndStrainPart(second_order_answer(question.scene, effects))
    except DeclinedError as reason:  # outside the range of the second order
        if not question.wants("dissipation"):
            return TiltAndStrainPart(left_out=str(reason))
        work_of_bodies = paths.path_with_bodies.work(paths.last_cycle)
        part_by_tilt_and_strain = tilt_and_strain_part_on_grids(
            question.scene, effects, work_of_bodies, str(reason)
        )
    work_of_half_planes = paths.path_of_half_planes.work(paths.last_cycle)
    if not work_of_half_planes > 0:
        return part_by_tilt_and_strain
    # Either way the work is that of half-planes without curvatures, which makes it uncertain.
    change_by_curvatures = paths.path_with_bodies.work(paths.last_cycle) / work_of_half_planes - 1
    # Fourth order over curvature at the largest contact half-width of the last cycle.
    ratio_of_fourth_order = ratio_of_next_order(effects, paths.largest_half_width)
    return part_by_tilt_and_strain._replace(
        relative_uncertainty=uncertain_fraction_of_tilt_and_strain(
            change_by_curvatures, ratio_of_fourth_order
        )
    )


def tilt_and_strain_part_on_grids(
    scene: Scene, effects: BodyEffects, work: float, reason: str
) -> TiltAndStrainPart:
    """Friction work that tilt and bulk strain of the finite bodies add in a cycle, by a numerical
    solution of half-planes on grids [energy per thickness].

    Used where the second order in tilt and strain does not hold. Grids give the relative change of
    the work; it is multiplied by `work`. Where nothing slips, where grids refuse the scene, or
    where the change is above 30 %, nothing is added and the reason is stated in `left_out`.

    Parameters
    ----------
    effects
        tilt and bulk strain of the bodies per P and per Q
    work
        friction work of the cycle without tilt and strain [energy per thickness]
    reason
        why the second order does not hold
    """
    try:
        half_plane_work = work_of_half_planes(scene)
        if not half_plane_work > 0:
            return TiltAndStrainPart(left_out=reason)  # nothing slips that could change
        # On grids, with its uncertainty; InputError where grids cannot solve the scene.
        relative_change = change_by_tilt_and_strain(scene, effects)
    except InputError as fault:
        return TiltAndStrainPart(
            left_out=f"{reason}, and grids do not take it: {first_line(fault)}"
        )
    if abs(relative_change.value) > _LARGEST_CHANGE_ON_GRIDS:
        return TiltAndStrainPart(
            left_out=f"{reason}, and grids make them {100 * relative_change.value:+.0f} % of the"
            " dissipation, which curvatures change too much"
        )
    added_work = Estimate(relative_change.value * work, relative_change.uncertainty * work)
    return TiltAndStrainPart(work_on_grids=added_work)


def _errors_of_steps(paths: _Paths) -> dict[str, float]:
    """Relative errors of shear and slip that the straight steps of the path cause, by field name.

    The path of half-planes by these steps is compared with exact theory at some instants of the
    last cycle and some points. An error is the largest difference over the largest f p, or over the
    largest slip. Points within 1 % of a half-width from an edge are left out. A field that is not
    asked for or 0 throughout has no error here, nor has any without friction.

    Parameters
    ----------
    paths
        load path of half-planes by straight steps; `last_cycle`: rows of the last cycle of the
        answer; the question with the fields that are wanted
    """
    path_of_half_planes = paths.path_of_half_planes
    field_names = tuple(name for name in ("shear", "slip") if paths.question.wants(name))
    friction_coefficient = path_of_half_planes.followed_path.friction
    if not field_names or not friction_coefficient:
        return {}
    row_numbers, places = _rows_and_places_compared(paths)
    exact_theory = _exact_theory(paths, field_names, places, paths.path_rows.time[row_numbers])
    point_fields = PointFields(path_of_half_planes, places)
    pressure = point_fields.pressure(row_numbers)
    largest_pressure = float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
    is_compared = _is_off_edges(path_of_half_planes, row_numbers, places)
    errors = {}
    for name in field_names:
        exact_values = exact_theory.values[name]
        field_by_steps = point_fields.shear if name == "shear" else point_fields.slip
        field_difference = np.where(
            is_compared, np.abs(field_by_steps(row_numbers) - exact_values), 0.0
        )
        largest_value = (
            friction_coefficient * largest_pressure
            if name == "shear"
            else float(np.max(np.abs(exact_values)))
        )
        if largest_value > 0:
            errors[name] = float(np.max(field_difference)) / largest_value
    return errors


def _rows_and_places_compared(paths: _Paths) -> tuple[Indices, Array]:
    """Rows of the last cycle and places at which fields by steps are compared with exact theory.

    They are the numbers of 9 rows, fewer of a short cycle, and 35 places from near the middle to
    the edge of contact (k,) [length].
    """
    last_cycle = paths.last_cycle
    row_numbers = np.unique(
        np.linspace(last_cycle.start, last_cycle.stop - 1, _INSTANTS_COMPARED).astype(int)
    )
    largest_half_width = float(np.max(paths.path_of_half_planes.half_width[row_numbers]))
    return row_numbers, np.linspace(0.0, largest_half_width, _PLACES_COMPARED)[1:]


def _is_off_edges(path: PathSeries, row_numbers: Indices, places: Array) -> NDArray[np.bool_]:
    """Whether places (k,) [length] are further than 1 % of the contact half-width from the edges of
    contact and of stick, (n, k). `row_numbers` (n,) are rows of the path. Next to an edge shear and
    slip are not smooth.
    """
    half_width = path.half_width[row_numbers, None]
    stick_half_width = np.nan_to_num(path.stick_half_width[row_numbers, None])
    # _EDGE_DISTANCE_SHARE: 0.01
    is_off_contact_edge = np.abs(places - half_width) > _EDGE_DISTANCE_SHARE * half_width
    is_off_stick_edge = np.abs(places - stick_half_width) > _EDGE_DISTANCE_SHARE * half_width
    return np.asarray(is_off_contact_edge & is_off_stick_edge)


def _exact_theory(
    paths: _Paths, field_names: Iterable[str], places: Array, time: Array
) -> Findings:
    """Exact half-plane theory of the scene, without what the bodies add: fields with these names at
    places (k,) [length] and times (n,).
    """
    question_of_half_planes = replace(
        paths.question,
        effects=None,
        fields=frozenset(field_names),
        x=places,
        time=time,
        cycles="all",
    )
    return findings_by_memory(question_of_half_planes, None)


def permanent_stick_half_width(
    path_with_bodies: PathSeries, cycle_rows: slice, centre: Array | float = 0.0
) -> float:
    """Half-width of the permanent stick zone, which sticks all through a cycle [length]; NaN where
    no point does.

    Parameters
    ----------
    path_with_bodies
        the followed path with the finite bodies
    cycle_rows
        instants of the cycle
    centre
        (n,) centre x of the stick zone at these instants [length]
    """
    # NaN, no stick zone, counts as 0.
    stick_half_width = np.nan_to_num(
        np.minimum(path_with_bodies.stick_half_width, path_with_bodies.half_width)[cycle_rows]
    )
    least_right_edge = np.min(centre + stick_half_width)
    largest_left_edge = np.max(centre - stick_half_width)
    permanent_half_width = float(least_right_edge - largest_left_edge) / 2
    always_sticks_somewhere = np.all(stick_half_width > 0)
    return (
        permanent_half_width if permanent_half_width > 0 and always_sticks_somewhere else math.nan
    )


def _reference_load(scene: Scene, normal_load: Array) -> float:
    """Load of the contact whose half-width the notes use [force per thickness]: the mean P of an
    elliptic load path, else the largest P. `normal_load` is P in the last cycle.
    """
    if scene.load.kind == "ellipse":
        return float(np.max(normal_load) + np.min(normal_load)) / 2
    return float(np.max(normal_load))


def _termination_and_message(paths: _Paths) -> tuple[str, str]:
    """How the followed path ended: the termination of the answer, "steady" or "end of path", and a
    sentence about it.

    - `paths.path_rows.period`: duration of a cycle, None without one
    - `paths.is_steady`: whether the last cycle of the answer ends in the state it started from
    - `paths.steady_from`: index of the first cycle that does
    - `paths.covered_cycles`: for each cycle of the answer, the index of the followed cycle that it
      equals
    """
    if paths.path_rows.period is None:
        return "end of path", "the path was followed to its end"
    if paths.steady_from is None or not paths.is_steady:
        return "end of path", f"no steady cycle among the first {paths.covered_cycles[-1] + 1}"
    return "steady", f"cycle {paths.steady_from + 1} ends in the state it started from"


def _notes_of(paths: _Paths, part_by_tilt_and_strain: TiltAndStrainPart) -> Iterator[str]:
    """Sentences for the notes of an answer: which effects of finite bodies are in it, what is left
    out, and why the work of the loads is not compared with the friction work.

    Parameters
    ----------
    paths
        load path followed with the bodies; `last_cycle`: rows of the last cycle of the answer;
        whether that cycle is steady; `path_rows.period`: duration of a cycle, None without one
    part_by_tilt_and_strain
        work that tilt and bulk strain of the bodies add, or why none is added
    """
    question = paths.question
    scene = question.scene
    # A note if Dundurs' beta is not 0: normal and tangential problem are solved uncoupled.
    yield from neglected_coupling(scene.material)
    # Load at which tilt and strain are made dimensionless: mean P of an ellipse, else its largest.
    reference_load = _reference_load(scene, paths.path_rows.normal_load[paths.last_cycle])
    half_width = float(paths.path_with_bodies.contact.half_width(reference_load))
    modulus = composite_modulus(scene.material)
    yield from notes_of_effects(paths.effects, half_width, modulus, part_by_tilt_and_strain)
    if part_by_tilt_and_strain.has_work:
        yield (
            "no closed integral of Q dU to compare the dissipation with: displacements are without"
            " what tilt and bulk strain do to slip"
        )
    if question.wants("dissipation") and paths.path_rows.period is not None and not paths.is_steady:
        yield (
            "the last cycle is not steady: no closed integral of Q dU to compare the dissipation"
            " with"
        )


def admissibility_checks_of(
    path_with_bodies: PathSeries, fields: Mapping[str, NDArray[Any]], row_numbers: Indices
) -> dict[str, Array]:
    """Checks of the laws of contact along a followed path, by name, (n,) each, 0 where satisfied.

        tangential_balance    |M - Q| / (f times the largest P)
        cone                  the largest |q| - f p over the points, over f times the largest p

    M is the tangential force that the contact carries: by its memory, and by the curvatures that
    the loads give to the faces. The balance is not checked while P = 0. The Coulomb limit ("cone")
    is checked where both pressure and shear were asked for.

    Parameters
    ----------
    path_with_bodies
        the path followed with the finite bodies
    fields
        pressure and shear at instants and points, (n, k) each
    row_numbers
        (n,) numbers of those instants
    """
    followed_path = path_with_bodies.followed_path
    checks = {"tangential_balance": _relative_missing_force(followed_path, row_numbers)}
    pressure = fields["pressure"]
    shear = fields["shear"]
    if np.any(np.isfinite(pressure)) and np.any(np.isfinite(shear)):
        friction_coefficient = followed_path.friction
        with np.errstate(invalid="ignore"):
            excess_shear = np.abs(shear) - friction_coefficient * pressure
        largest_excess = np.fmax.reduce(excess_shear, axis=1, initial=0.0)
        largest_pressure = float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
        largest_limit = friction_coefficient * largest_pressure
        checks["cone"] = largest_excess / max(largest_limit, np.finfo(float).tiny)
    return checks


def _relative_missing_force(followed_path: FollowedPath, row_numbers: Indices) -> Array:
    """Error of tangential equilibrium at some rows of a followed path, (n,): |M - Q| divided by f
    times the largest P of the path, 0 while P = 0.

    M is the tangential force that the contact carries by its memory: M = F + kt G + t4 G_4 at the
    edge of contact. F was locked in while the flat punches stuck. kt and t4 are the curvatures in
    x^2/2 and x^4/24 that the loads give to the faces. G and G_4 are the loads that press these
    shapes into contact up to the edge.
    """
    largest_friction_force = max(
        followed_path.friction * float(np.max(followed_path.normal_load)), np.finfo(float).tiny
    )
    # edge_s: coordinate s of the edge of contact in the table of flat punches
    edge_s = followed_path.edge_s[row_numbers]
    parabola_load = followed_path.table.parabola_load(edge_s)
    fourth_load = followed_path.table.fourth_load(edge_s)
    # F, then kt G and t4 G_4, all at the edge of contact
    carried_force = followed_path.pieces.locked_in_force[followed_path.uppermost_piece[row_numbers]]
    carried_force = carried_force + followed_path.tangential_curvature[row_numbers] * parabola_load
    carried_force = carried_force + followed_path.tangential_fourth[row_numbers] * fourth_load
    missing_force = np.abs(carried_force - followed_path.tangential_load[row_numbers])
    is_pressed = followed_path.normal_load[row_numbers] > 0
    return np.where(is_pressed, missing_force, 0.0) / largest_friction_force
