"""Corrected half-plane theory: the answer with what finite bodies add to the compliance of
half-planes, as `Findings`.

Taken are the even numbers of `BodyEffects`, exact but for the step of the path: curvatures N, N_Q
of the gap and T, T_P of the faces and their next order N_4, T_4, N_22, T_22 (`corrected_memory`),
compliances c_n and c_t. With p_2, p_4 and q_2, q_4 the moments int x^2 p dx, int x^4 p dx and those
of q, and half-planes whose datum is that of the effects::

    approach = (A/pi) int ln(2 L/c) dP + c_n P + N p_2/2 + T_P q_2/2 + N_4 p_4/24
    U        = (A/pi) int ln(2 L/c) dM + c_t Q + T q_2/2 + N_Q p_2/2 + T_4 q_4/24

The fractions are those of reciprocity: a force at s moves x as a force at x moves s. What the order
after the next may leave is in the errors of the dissipation, of the pressure and of the half-width
(`next_order`).

Where a slip zone does not reach the edge, q of the memory curve is beyond f p by the second order;
points slip further there until it is not (`inner_slip`). This is in shear, slip and state, and in
neither U nor W.

The odd numbers o = (alpha_P, alpha_Q, e_P, e_Q) P0/(a0/R), tilt and bulk strain, move dissipation,
pressure and half-widths of a symmetric profile by the second order of o, the places of edges by the
first. Of a parabola (`odd_memory`) both are in the dissipation, in the edges of contact and stick,
and in the permanent stick half-width; in no field at points. A note says how large they are, and
why they are left out where they are. Of unlike materials (Dundurs' beta) they count in the first
order.

A path is followed by straight steps, some 400 a cycle. What the same steps make of half-planes is
compared with exact theory: W and W(x) are exact theory's plus the difference of two paths of these
steps, and from the difference of both answers of half-planes the error is stated.

# notation: A = 2/E*, a contact half-width, eta load of the profile's punches, G that of a
#           parabola's per curvature
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator, Mapping
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
from scenes.array_types import Array
from scenes.body_effects import ZERO
from scenes.errors import first_line
from semi_analytic.answer import (
    Findings,
    Question,
    between,
    mirrored_points,
    neglected_coupling,
)
from semi_analytic.answer_by_memory import by_memory, folded, path_of_question
from semi_analytic.corrected_memory import (
    Curvatures,
    Followed,
    PunchMoments,
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
    LEFT_IN_ANY_CASE,
    has_next_order,
    left_of_curvatures,
    left_of_tilt_and_strain,
    ratio_of_next_order,
    with_these_alone,
)
from semi_analytic.odd_memory import ODD_NUMBERS, Declined, OddAnswer, odd_answer
from semi_analytic.profiles import SymmetricContact, contact_of
from semi_analytic.tilt_and_strain import change_by_tilt_and_strain, work_of_half_planes

Indices = NDArray[np.int64]

_OF_WORK = frozenset(("dissipation", "dissipation_density"))
# Rows that are followed at most: each takes some 30 us and two pieces of memory curve.
_MOST_ROWS = 200_000
# Room of the table of punches beyond the largest contact.
_BEYOND = 1.02
# Two instants of this share of the path are one.
_SAME = 1e-12
# Punches whose turning points are rows, by their G over that of the largest.
_SHARES = np.linspace(0.0, 1.0, 6)
# Share of a step within which a turning point is at a row: a step as short would hold no slip.
_BESIDE = 0.02
# Share of f P by which two memory curves may differ and be the same state.
_STEADY = 1e-9
# Of the error that the steps make of W of half-planes, what they leave in the change by the bodies:
# 0.14 at most on three ellipses with each of the curvatures, by steps that were ten times shorter.
_OF_STEPS = 0.5
# Of the change of W by steps that are halved, what is left: 1/3 falls with the square of a step.
_OF_HALVED = 2.0
# Share of the largest P up to which growth in stick is short: chords of 0.5 % of it leave 5e-8 of W
# at most of six library scenes with the numbers of `blocks`.
_SHORT_CHORD = 0.01
# The largest change of the dissipation by tilt and bulk strain that is added, on grids.
_MOST_ON_GRIDS = 0.3
# Instants and places at which the error of the steps is looked at, and the share of a half-width
# within which a point is at an edge.
_INSTANTS = 9
_PLACES = 36
_NEAR = 0.01
# Places at which |q| is compared with f p, and the share of the largest f p by which it is beyond:
# a third of what breaks a law of an answer by steps.
_LOOKED_AT_FIRST, _LOOKED_AT = 30, 100
_BEYOND_LIMIT = 3e-7
# Rows of which this is done at once: 2 MB.
_AT_ONCE = 2000


# ------------------------------------------------------------------------------------- the effects
def curvatures_of(effects: BodyEffects) -> Curvatures:
    """Curvatures that finite bodies add to gap and faces per unit of load, as plain numbers without
    their uncertainties.

    `effects` holds each as a value with its uncertainty. Second order [1/(stress length^2)]: of the
    gap per P and per Q, of the tangential displacement of the faces per Q and per P. The fourth
    order [1/(stress length^4)] is in `*_fourth` and `*_mixed`.
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


def odd_part(effects: BodyEffects, half_width: float, modulus: float) -> tuple[float, ...]:
    """o = (alpha_P, alpha_Q, e_P, e_Q) P0/(a0/R) with a0/R = 4 P0/(pi E* a0), Hertz' law, for any
    profile.
    """
    unit = math.pi * modulus * half_width / 4
    return tuple(getattr(effects, name).value * unit for name in ODD_NUMBERS)


class OddPart(NamedTuple):
    """What tilt and bulk strain make of dissipation and edges.

    Attributes
    ----------
    answer
        of `odd_memory`; None where there is none
    left_out
        why there is none; empty where the effects have nothing odd
    on_grids
        work that they add in the last cycle, on grids, where the second order does not hold; it
        counts for each cycle
    left
        of that work, in its ratio, what curvatures and next order of the bodies make uncertain
    """

    answer: OddAnswer | None = None
    left_out: str = ""
    on_grids: Estimate | None = None
    left: float = 0.0

    def work(self, cycle: int) -> Estimate:
        """Work that they add in a cycle that was followed."""
        if self.on_grids is None and self.answer is None:
            return ZERO
        added = self.on_grids
        if self.answer is not None:
            works = self.answer.works
            added = works[min(cycle, len(works) - 1)]
        assert added is not None  # for the type checker
        return Estimate(added.value, added.uncertainty + self.left * abs(added.value))

    def centres(self, time: Array) -> tuple[Array, Array]:
        """Centres of contact and of stick at instants (n,), (n,) each."""
        if self.answer is None:
            return np.zeros(len(time)), np.zeros(len(time))
        return self.answer.centres(time)


class OddInAnswer(NamedTuple):
    """Where tilt and bulk strain of the bodies count beside the dissipation, in words: where they
    are covered, and where they are not; where the even numbers count.
    """

    covered: str
    left_out: str
    even: str


OF_LOADS = OddInAnswer(
    covered=(
        "move edges of contact and stick, in the first, and U and the approach of a parabola by the"
        " moment of the pressure; fields at points, shear at edges and edge tension are without"
        " them"
    ),
    left_out="are left out, but for the moment of the pressure in U and approach of a parabola",
    even="the curvatures N, N_Q, T, T_P, their next order and the compliances c_n, c_t",
)
OF_RIG = OddInAnswer(
    covered=(
        "change U of a parabola by the moment of the pressure; edges, fields at points, and P where"
        " the approach is prescribed, are without them"
    ),
    left_out="are left out, but for the moment of the pressure in U of a parabola",
    even="the curvatures N, N_Q, T, T_P and the compliances c_n, c_t",
)


def notes_of_effects(
    effects: BodyEffects,
    half_width: float,
    modulus: float,
    odd: OddPart,
    in_answer: OddInAnswer = OF_LOADS,
) -> Iterator[str]:
    """Sentences for the notes of an answer: which effects of the finite bodies its values contain.

    The even ones (curvatures, compliances) are contained. The odd ones (tilt and bulk strain) are
    in the dissipation where they could be found; else the sentence gives their sizes and the
    reason.

    Parameters
    ----------
    effects
        what the finite bodies add to the compliance of half-planes
    half_width, modulus
        contact half-width [length] and E* [stress], which make the sizes dimensionless
    odd
        work that tilt and bulk strain add, or why it is left out
    in_answer
        words for the values that contain each kind of effect
    """
    yield f"effects: {in_answer.even} of the bodies are in these values"
    odd_values = odd_part(effects, half_width, modulus)
    if not any(odd_values):
        return
    values_text = ", ".join(f"{value:.3g}" for value in odd_values)
    odd_values_text = f"o = (alpha_P, alpha_Q, e_P, e_Q) P0/(a0/R) = ({values_text})"
    if odd.answer is not None or odd.on_grids is not None:
        added_work = odd.work(-1)
        method = "in the second order" if odd.on_grids is None else "on grids"
        yield (
            f"effects: tilt and bulk strain of the bodies, {odd_values_text}, add"
            f" {added_work.value:.3g} ± {added_work.uncertainty:.1g} to the dissipation, {method},"
            f" and {in_answer.covered}"
        )
        return
    consequence = "which change the dissipation in the second order"
    if effects.dundurs_beta:
        consequence = "which change the dissipation in the first order: the materials are unlike"
    reason = ""
    if odd.left_out:
        reason = f"; left out because {odd.left_out}; by how much the dissipation errs is not known"
    yield (
        f"effects: tilt and bulk strain of the bodies {in_answer.left_out},"
        f" {odd_values_text}, {consequence}{reason}"
    )


def notes_of_batch(effects: BodyEffects) -> Iterator[str]:
    """Sentences for the notes of an array of answers: which effects of the finite bodies are in its
    values, and which are left out.

    An array has no single contact half-width, so no sizes of what is left out are stated.
    """
    yield "effects: the curvatures N, N_Q, T, T_P of the bodies are in these values"
    if has_next_order(effects):
        yield (
            "effects: the next order of the bodies, N_4, T_4, N_22 and T_22, is left out; `solve`"
            " takes it"
        )
    if any(getattr(effects, name).value for name in ODD_NUMBERS):
        yield (
            "effects: tilt and bulk strain of the bodies are left out; `solve` states how large"
            " they are for a scene"
        )


# ---------------------------------------------------------------------------------- rows of a path
@dataclass(frozen=True, eq=False)
class PathRows:
    """The rows of a path that is followed by straight steps.

    Attributes
    ----------
    time, normal_load, tangential_load
        (n,)
    ends
        row at which the initial loading ends, and each cycle; the last row where there is no cycle
    period
        duration of a cycle, None for a path that does not repeat
    """

    time: Array
    normal_load: Array
    tangential_load: Array
    ends: tuple[int, ...]
    period: float | None

    @property
    def cycles(self) -> list[slice]:
        """The rows of each cycle; the steps that end there are those of the cycle."""
        if self.period is None:
            return [slice(0, len(self.time))]
        return [slice(self.ends[k], self.ends[k + 1] + 1) for k in range(len(self.ends) - 1)]


@dataclass(frozen=True, eq=False)
class _Route:
    """A path of loads that was followed by half-plane theory: its marks, and P and Q anywhere.

    Attributes
    ----------
    scene, path
        what was followed
    """

    scene: Scene
    path: LoadSeries | History

    @cached_property
    def instants(self) -> Array:
        """Theory's own instants, some 400 a cycle, its events among them."""
        return self.path.default_times(False, False)[0]

    @property
    def period(self) -> float | None:
        """Duration of a cycle."""
        return self.path.period

    @property
    def start(self) -> float:
        """Time of the unloaded state."""
        return float(self.instants[0])

    @property
    def cycle_ends(self) -> list[float]:
        """Ends of the initial loading and of two cycles; start and end of a path without cycle."""
        end_time = float(self.instants[-1])
        if self.period is None:
            return [self.start, end_time]
        cycle_start = end_time - len(self.path.cycles) * self.period
        return [cycle_start + k * self.period for k in range(3)]

    def rows(self, time: Array) -> PathRows:
        """Instants at which the load path is cut into straight steps, with the loads P and Q there.

        The cuts are the instants `time` (n,) and the ends of the cycles. Of two instants nearer
        than 1e-12 of the path's duration one goes; the end of a cycle stays.

        Raises
        ------
        InputError
            If more instants result than can be followed.
        """
        cycle_ends = self.cycle_ends
        duration = cycle_ends[-1] - self.start
        times_inside = time[(time > self.start) & (time < cycle_ends[-1])]
        # Of two instants that are one a mark stays.
        distance_to_mark = np.min(
            np.abs(times_inside[:, None] - np.array([self.start, *cycle_ends])), axis=1
        )
        times_inside = times_inside[distance_to_mark > _SAME * duration]
        instants = np.unique(np.concatenate([times_inside, [self.start], cycle_ends]))
        instants = instants[np.diff(instants, prepend=-np.inf) > _SAME * duration]
        if len(instants) > _MOST_ROWS:
            raise InputError(
                f"effects: the load path has {len(instants):,} rows and corrected theory follows"
                f" {_MOST_ROWS:,} at most: take a part of the path, or half-planes without effects"
            )
        if isinstance(self.path, LoadSeries):
            normal_load, tangential_load = _loads_of_series(self.path, instants)
        else:
            normal_load, tangential_load = self.scene.load.path().at(instants)
        rows_of_ends = tuple(int(np.argmin(np.abs(instants - mark))) for mark in cycle_ends)
        if self.period is None:
            rows_of_ends = rows_of_ends[1:]
        positive_load = np.maximum(normal_load, 0.0)
        return PathRows(instants, positive_load, tangential_load, rows_of_ends, self.period)

    def first_rows(self, time: Array | None) -> PathRows:
        """First choice of the instants that cut the load path into straight steps, with P and Q
        there.

        They are the instants at which half-plane theory was solved, and those that the caller asked
        for, `time` (None: no more). Of a path that repeats, the instants of the last cycle that
        theory solved are also taken in the first two cycles.
        """
        instants = self.instants
        marks = self.cycle_ends
        if self.period is not None:
            solved = len(self.path.cycles)
            last_cycle = instants[instants >= marks[0] + (solved - 1) * self.period]
            last_cycle = last_cycle - (solved - 1) * self.period
            instants = np.concatenate([instants, last_cycle, last_cycle + self.period])
        if time is not None:
            asked_for, _ = time_in_followed_path(time, self.start, marks[-1], self.period)
            instants = np.append(instants, np.clip(asked_for, self.start, marks[-1]))
        return self.rows(instants)

    def with_turning_points(
        self, rows: PathRows, friction: float, curvatures: Curvatures, parabola: float
    ) -> PathRows:
        """Steps of the load path, cut further where slip turns round for punches inside the
        contact.

        A flat punch up to which a parabola carries G slips at the Coulomb limit

            bound = Q - s f P + (s f kn - kt) G,    s = +1, -1.

        Here kn and kt are the curvatures that the loads add to the gap and to the faces. Where the
        bound turns, slip turns. Half-planes (kn = kt = 0) turn at other instants, so that these
        must be added.

        Parameters
        ----------
        rows
            the steps so far
        friction
            f
        curvatures
            what P and Q add to kn and kt, per load
        parabola
            G of the largest punch [force per thickness times length]
        """
        if isinstance(self.path, LoadSeries):
            return rows
        normal_load = rows.normal_load
        tangential_load = rows.tangential_load
        gap_curvature = curvatures.of_gap(normal_load, tangential_load)
        face_curvature = curvatures.of_faces(normal_load, tangential_load)
        turning_times = []
        for direction in (1, -1):
            load_term = tangential_load - direction * friction * normal_load
            curvature_term = direction * friction * gap_curvature - face_curvature
            for parabola_share in _SHARES:
                bound = load_term + parabola_share * parabola * curvature_term
                turning_times.append(_turning_points(rows.time, bound))
        instants = np.concatenate(turning_times)
        row_after = np.clip(np.searchsorted(rows.time, instants), 1, len(rows.time) - 1)
        step_length = rows.time[row_after] - rows.time[row_after - 1]
        share_of_step = (instants - rows.time[row_after - 1]) / step_length
        is_between = (share_of_step > _BESIDE) & (share_of_step < 1 - _BESIDE)
        return self.rows(np.concatenate([rows.time, instants[is_between]]))


def _turning_points(time: Array, values: Array) -> Array:
    """Vertices of parabolas through three rows each, where values (n,) over time (n,) turn."""
    rises = np.diff(values)
    steps = np.diff(time)
    slopes = rises / steps
    row_numbers = np.flatnonzero(slopes[1:] * slopes[:-1] < 0) + 1
    mean_steps = (steps[row_numbers - 1] + steps[row_numbers]) / 2
    curvatures = (slopes[row_numbers] - slopes[row_numbers - 1]) / mean_steps
    return np.asarray(
        (time[row_numbers - 1] + time[row_numbers]) / 2 - slopes[row_numbers - 1] / curvatures
    )


def _loads_of_series(series: LoadSeries, time: Array) -> tuple[Array, Array]:
    """P and Q on straight steps at instants (n,), also in cycles after those that were followed."""
    rows = np.concatenate([part.rows + np.array([part.delay, 0.0, 0.0]) for part in series.parts])
    time_in_path = time
    if series.period is not None:
        path_end = float(rows[-1, 0])
        periods_beyond = np.maximum(np.ceil((time - path_end) / series.period - _SAME), 0.0)
        time_in_path = time - periods_beyond * series.period
    return np.interp(time_in_path, rows[:, 0], rows[:, 1]), np.interp(
        time_in_path, rows[:, 0], rows[:, 2]
    )


# ----------------------------------------------------------------------------------------- fields
@dataclass(frozen=True, eq=False)
class PathSeries:
    """Half-widths, movements and work of a followed path at its rows.

    Attributes
    ----------
    followed
        the path
    contact, modulus
        normal contact of half-planes, E*
    effects
        what the bodies add; None: nothing
    rigid_displacement
        (n,) how far the bodies slid as a whole or moved while apart; None: they never did
    """

    followed: Followed
    contact: SymmetricContact
    modulus: float
    effects: BodyEffects | None
    rigid_displacement: Array | None = None

    @property
    def unit_compliance(self) -> float:
        """A/pi."""
        return 2 / (math.pi * self.modulus)

    @cached_property
    def half_width(self) -> Array:
        """a, (n,)."""
        half = self.followed.table.half_width(self.followed.edge)
        return np.where(self.followed.normal_load > 0, half, self.contact.least_half_width)

    @cached_property
    def stick_half_width(self) -> Array:
        """c, (n,); a in full stick, NaN in full slip."""
        innermost = self.followed.innermost
        slips = self.followed.sense != 0
        half = self.followed.table.half_width(innermost)
        stick = np.where(slips, half, self.half_width)
        return np.where((stick <= 0) | (slips & (innermost <= 0)), np.nan, stick)

    @cached_property
    def tangential_displacement(self) -> Array:
        """Relative tangential displacement U of the two bodies at each instant of the path, (n,)
        [length].

        It is what the shear does between half-planes, plus any sliding as a whole, plus what finite
        bodies add: c_t Q + T q_2/2 + N_Q p_2/2 + T_4 q_4/24 and the part of their tilt. p_k and q_k
        are the moments int x^k p dx and int x^k q dx; T, N_Q, T_4 curvatures per load, c_t a
        compliance.
        """
        _, shear_logarithm = self._logarithms
        displacement = self.unit_compliance * shear_logarithm
        if self.rigid_displacement is not None:
            displacement = displacement + self.rigid_displacement
        if self.effects is None:
            return displacement
        curvatures = curvatures_of(self.effects)
        followed = self.followed
        moment_sum = curvatures.tangential * followed.shear_second_moment
        moment_sum = moment_sum + curvatures.normal_under_shear * followed.pressure_second_moment
        if curvatures.tangential_fourth:
            moment_sum = (
                moment_sum + curvatures.tangential_fourth * followed.shear_fourth_moment / 12
            )
        part_of_load = self.effects.tangential_compliance.value * self.followed.tangential_load
        part_of_tilt, _ = self._moved_by_tilt
        return np.asarray(displacement + part_of_load + moment_sum / 2 + part_of_tilt)

    @cached_property
    def normal_approach(self) -> Array:
        """Approach of the two bodies at each instant of the path, (n,) [length].

        It is that of half-planes under the pressure, plus what finite bodies add: c_n P + N p_2/2 +
        T_P q_2/2 + N_4 p_4/24 and the part of their tilt. p_k and q_k are the moments int x^k p dx
        and int x^k q dx; N, T_P, N_4 curvatures per load, c_n a compliance.
        """
        pressure_logarithm, _ = self._logarithms
        approach = self.unit_compliance * pressure_logarithm
        if self.effects is None:
            return approach
        curvatures = curvatures_of(self.effects)
        followed = self.followed
        moment_sum = curvatures.normal * followed.pressure_second_moment
        moment_sum = (
            moment_sum + curvatures.tangential_under_pressure * followed.shear_second_moment
        )
        if curvatures.normal_fourth:
            moment_sum = (
                moment_sum + curvatures.normal_fourth * followed.pressure_fourth_moment / 12
            )
        part_of_load = self.effects.normal_compliance.value * self.followed.normal_load
        _, part_of_tilt = self._moved_by_tilt
        return np.asarray(approach + part_of_load + moment_sum / 2 + part_of_tilt)

    @cached_property
    def _moved_by_tilt(self) -> tuple[Array, Array]:
        """Displacements that the tilt of finite bodies adds to U and to the normal approach, (n,)
        each [length]; 0 unless the profile is a parabola.

        A parabola of radius R tilted by alpha = alpha_P P + alpha_Q Q touches about x = -alpha R.
        The moment of its pressure is then m = -R alpha P. By reciprocity m moves the bodies by
        alpha_Q m tangentially and alpha_P m normally. A tilted parabola is pressed in by R
        alpha^2/2 less.
        """
        load = self.followed.normal_load
        zeros = np.zeros(len(load))
        if self.effects is None or not isinstance(self.contact, HertzContact):
            return zeros, zeros
        under_pressure = self.effects.tilt_under_pressure.value
        under_shear = self.effects.tilt_under_shear.value
        tilt = under_pressure * load + under_shear * self.followed.tangential_load
        moment = -self.contact.radius * tilt * load
        approach_lost = self.contact.radius * tilt**2 / 2
        return under_shear * moment, under_pressure * moment - approach_lost

    @cached_property
    def _logarithms(self) -> tuple[Array, Array]:
        """int ln(2 L/c) dP and dM over the punches, (n,) each."""
        followed = self.followed
        datum = self.contact.datum_length if self.effects is None else self.effects.datum_length
        at_tops = _logarithms(followed.table, followed.pieces.top, datum)
        at_edge = _logarithms(followed.table, followed.edge, datum)
        return followed.pressure_integral(at_edge), followed.shear_integral(at_tops, at_edge)

    @cached_property
    def _inner_senses(self) -> Indices:
        """Direction of slip, +1 or -1, at each instant at which the shear of the memory curve
        exceeds the Coulomb limit inside the contact, |q| > f p; 0 elsewhere. (n,)

        The memory curve is the locked-in tangential force over the half-width of the flat punches.
        Half-planes never exceed the limit; curvatures of finite bodies make it possible. A few
        places are looked at first, more of them at suspect instants and two instants to each side.
        """
        followed = self.followed
        senses = np.zeros(len(followed.edge), dtype=np.int64)
        curvatures = (
            followed.normal_curvature,
            followed.tangential_curvature,
            followed.normal_fourth,
            followed.tangential_fourth,
        )
        if not np.any(curvatures):
            return senses
        largest_load = np.array([np.argmax(followed.normal_load)])
        middle_fields = PointFields(self, np.zeros(1))
        tolerance = (
            _BEYOND_LIMIT * followed.friction * float(middle_fields.pressure(largest_load)[0, 0])
        )
        # A hundredth of it at some places, at a row or next to it, shows where to look closer.
        largest_excess, _ = self._beyond_limit(np.arange(len(senses)), _LOOKED_AT_FIRST)
        is_suspect = (largest_excess > tolerance / 100).astype(float)
        rows_to_check = np.flatnonzero(np.convolve(is_suspect, np.ones(5), mode="same"))
        largest_excess, signs = self._beyond_limit(rows_to_check, _LOOKED_AT)
        senses[rows_to_check] = np.where(largest_excess > tolerance, signs, 0)
        return senses

    def _beyond_limit(self, rows: Indices, count: int) -> tuple[Array, Array]:
        """How far the shear of the memory curve exceeds the Coulomb limit at each instant: the
        largest |q| - f p over `count` places from the middle to the edge, and the sign of q there.

        The memory curve is the locked-in tangential force over the half-width of the flat punches.
        `rows` (n,) are the numbers of the instants; both values returned are (n,), the first
        [stress].
        """
        shares_of_half_width = np.sin(np.linspace(0.0, math.pi / 2, count))
        fields_at_places = PointFields(self, float(np.max(self.half_width)) * shares_of_half_width)
        largest_excess = np.zeros(len(rows))
        signs = np.zeros(len(rows))
        for first_of_chunk in range(0, len(rows), _AT_ONCE):
            rows_at_once = slice(first_of_chunk, first_of_chunk + _AT_ONCE)
            shear = fields_at_places.shear_of_memory(rows[rows_at_once])
            limit = self.followed.friction * fields_at_places.pressure(rows[rows_at_once])
            excess = np.nan_to_num(np.abs(shear) - limit)
            place_of_largest = np.argmax(excess, axis=1)[:, None]
            largest_excess[rows_at_once] = np.take_along_axis(excess, place_of_largest, axis=1)[
                :, 0
            ]
            signs[rows_at_once] = np.sign(np.take_along_axis(shear, place_of_largest, axis=1)[:, 0])
        return largest_excess, signs

    @cached_property
    def _inner_slips(self) -> dict[int, InnerSlip]:
        """What was worked out at rows."""
        return {}

    def inner_slips(self, rows: Indices) -> Iterator[tuple[int, InnerSlip]]:
        """What slips further at those of some rows at which |q| of the memory curve is beyond f p,
        with the number of the row among them.
        """
        for row_place in np.flatnonzero(self._inner_senses[rows]).tolist():
            row = int(rows[row_place])
            if row not in self._inner_slips:
                self._inner_slips[row] = self._inner_slip(row)
            yield row_place, self._inner_slips[row]

    def _inner_slip(self, row: int) -> InnerSlip:
        """Extra slip inside the contact at instant number `row`, where the shear of the memory
        curve exceeds the Coulomb limit, |q| > f p.

        The memory curve is the locked-in tangential force over the half-width of the flat punches.
        `inner_slip` finds the slip by the tractions there, the contact half-width, the stick
        half-width and the half-widths at which the slip zones of the memory curve end.
        """
        followed = self.followed

        def tractions(x: Array) -> tuple[Array, Array]:
            point_fields = PointFields(self, x)
            return point_fields.shear_at(row), followed.friction * point_fields.pressure(
                np.array([row])
            )[0]

        half_width = float(self.half_width[row])
        stick_edge, *inner_zone_half_widths = followed.table.half_width(
            [followed.stick_edge[row], *followed.inner_zone[row]]
        )
        # Without slip at the edge all of the contact sticks.
        edge_of_stick = stick_edge if followed.direction[row] else half_width
        ends_of_zones = np.array([stick_edge, *inner_zone_half_widths])
        sense = int(self._inner_senses[row])
        return inner_slip(tractions, sense, half_width, ends_of_zones, edge_of_stick, self.modulus)

    def loop_work(self, rows: slice) -> float:
        """Closed integral of Q dU + P d(approach) over a cycle."""
        followed = self.followed
        tangential = area_of_loop(
            followed.tangential_load[rows], self.tangential_displacement[rows]
        )
        return tangential + area_of_loop(followed.normal_load[rows], self.normal_approach[rows])

    def work(self, rows: slice) -> float:
        """Friction work of the steps of a cycle, or of the path."""
        return self.unit_compliance * float(np.sum(self.followed.step_work[rows][1:]))


class PointFields:
    """Fields of a followed path at distances |x| (k,) from the middle.

    Parameters
    ----------
    series
        the path
    x
        (k,)
    """

    def __init__(self, series: PathSeries, x: Array) -> None:
        self.series = series
        self._followed = series.followed
        self._x = x
        # Rows, ascending, of which the slip was worked out, and the slip.
        self._known_slip: tuple[Indices, Array] = (np.zeros(0, dtype=np.int64), np.zeros((0, 0)))

    def pressure(self, rows: Indices) -> Array:
        """p, (n, k)."""
        followed = self._followed
        profile_load = followed.table.load(followed.edge[rows])[:, None]
        profile_pressure = self.series.contact.pressure(self._x, profile_load)
        curvature = followed.normal_curvature[rows]
        fourth_coefficient = followed.normal_fourth[rows]
        return profile_pressure + self._of_bends(
            self.series.half_width[rows], curvature, fourth_coefficient
        )

    def shear(self, rows: Indices) -> Array:
        """q, (n, k)."""
        shear = self.shear_of_memory(rows)
        for row_place, further in self.inner_slips(rows):
            shear[row_place] += further.shear
        return shear

    def shear_of_memory(self, rows: Indices) -> Array:
        """q without what slips further inside the contact, (n, k)."""
        followed = self._followed
        curvature = followed.tangential_curvature[rows]
        fourth_coefficient = followed.tangential_fourth[rows]
        shear_of_faces = self._of_bends(self.series.half_width[rows], curvature, fourth_coefficient)
        return self._shear_of_curves(rows) + shear_of_faces

    def shear_at(self, row: int) -> Array:
        """Shear traction q at the points at instant number `row`, (k,) [stress], as the memory
        curve has it: without the extra slip inside the contact.

        The memory curve, the locked-in tangential force over the half-width of the punches, is a
        chain of pieces. Each has a constant rise of that force per load of flat punches (of the
        profile, of a parabola, of x^4/24). A piece adds these slopes times the pressure of its
        punches. The curvature that the loads give to the faces adds the rest.
        """
        pieces = self._followed.pieces
        numbers_of_pieces = pieces.chain(int(self._followed.uppermost_piece[row]))
        half_widths = self._followed.table.half_width(pieces.top[numbers_of_pieces])
        profile_pressures = self.series.contact.pressure_rise(
            self._x, pieces.load[numbers_of_pieces, None]
        )
        parabola_pressures, fourth_pressures = self._inside(half_widths)
        shear = pieces.slope[numbers_of_pieces[1:]] @ np.diff(profile_pressures, axis=0)
        shear = shear + pieces.parabola_slope[numbers_of_pieces[1:]] @ np.diff(
            parabola_pressures, axis=0
        )
        shear = shear + pieces.fourth_slope[numbers_of_pieces[1:]] @ np.diff(
            fourth_pressures, axis=0
        )
        curvature = self._followed.tangential_curvature[[row]]
        fourth_coefficient = self._followed.tangential_fourth[[row]]
        shear_of_faces = self._of_bends(
            self.series.half_width[[row]], curvature, fourth_coefficient
        )
        return np.asarray(shear + shear_of_faces[0])

    def slip(self, rows: Indices) -> Array:
        """s, (n, k)."""
        known_rows, known_slip = self._known_slip
        if len(known_rows):
            place_among_known = np.minimum(np.searchsorted(known_rows, rows), len(known_rows) - 1)
            if np.array_equal(known_rows[place_among_known], rows):
                return known_slip[place_among_known]
        slip = self._slip(rows)
        if np.all(np.diff(rows) > 0):
            self._known_slip = (rows, slip)
        return slip

    def _slip(self, rows: Indices) -> Array:
        """Relative slip s of the faces at the points, at instants `rows`, (n, k) [length].

        A memory curve is the locked-in tangential force over the half-width of the flat punches.
        Four parts add up: slip by the memory curves, the curvature of the faces outside the
        contact, sliding as a whole, and the extra slip inside the contact.
        """
        followed = self._followed
        slip = self._slip_of_curves(rows)
        # Inside the contact what sticks follows the curvature of the faces; outside it does not.
        curvature = followed.tangential_curvature[rows, None]
        fourth_coefficient = followed.tangential_fourth[rows, None]
        if np.any(curvature) or np.any(fourth_coefficient):
            slip_by_parabola, slip_by_fourth = self._outside(self.series.half_width[rows])
            slip = slip + curvature * (slip_by_parabola - self._x**2 / 2)
            slip = slip + fourth_coefficient * (slip_by_fourth - self._x**4 / 24)
        if self.series.rigid_displacement is not None:
            slip = slip + self.series.rigid_displacement[rows, None]
        for row_place, further in self.inner_slips(rows):
            slip[row_place] += further.slip
        return np.asarray(slip)

    def inner_slips(self, rows: Indices) -> Iterator[tuple[int, SlipAtPoints]]:
        """What slips further at some rows, as of the path, at the points."""
        for row_place, further in self.series.inner_slips(rows):
            row = int(rows[row_place])
            if row not in self._inner_slips:
                self._inner_slips[row] = further.at(self._x)
            yield row_place, self._inner_slips[row]

    @cached_property
    def _inner_slips(self) -> dict[int, SlipAtPoints]:
        """What was worked out at rows."""
        return {}

    def work(self, rows: slice) -> Array:
        """Friction work per area W(x) of one cycle at the points, (k,) [force per length], for the
        instants `rows` of that cycle.

        Each step adds the mean of f p at its two ends times the distance that the point slips. A
        point inside the smaller stick zone of the step does not slip.
        """
        row_numbers = np.arange(len(self._followed.edge))[rows]
        friction_limit = self._followed.friction * self.pressure(row_numbers)
        friction_limit = np.where(np.isfinite(friction_limit), friction_limit, 0.0)
        mean_limit = (friction_limit[1:] + friction_limit[:-1]) / 2
        slip_distance = np.abs(np.diff(self.slip(row_numbers), axis=0))
        stick_half_widths = np.nan_to_num(self.series.stick_half_width[row_numbers])
        least_stick = np.minimum(stick_half_widths[1:], stick_half_widths[:-1])[:, None]
        has_slip = self._followed.sense[row_numbers[1:], None] != 0
        is_rubbed = has_slip & (self._x >= least_stick)
        return np.asarray(np.sum(np.where(is_rubbed, mean_limit * slip_distance, 0.0), axis=0))

    def _shear_of_curves(self, rows: Indices) -> Array:
        """Shear traction that the memory curves carry at instants `rows`, at the points, (n, k)
        [stress].

        A memory curve, the locked-in tangential force over the half-width of the punches, is a
        chain of pieces of constant slopes. Its shear is the sum over the pieces of each slope times
        the pressure of the punches of the piece: punches of the profile, of a parabola x^2/2 and of
        x^4/24.
        """
        followed = self._followed
        pieces, curves = followed.pieces.pieces_of_curves(followed.uppermost_piece[rows])
        profile_pressures = self.series.contact.pressure_rise(self._x, pieces.load[:, None])
        terms = [(pieces.slope, profile_pressures)]
        if np.any(pieces.parabola_slope) or np.any(pieces.fourth_slope):
            parabola_pressures, fourth_pressures = self._inside(
                followed.table.half_width(pieces.top)
            )
            terms += [
                (pieces.parabola_slope, parabola_pressures),
                (pieces.fourth_slope, fourth_pressures),
            ]
        return pieces.integrals_at_tops(*terms)[curves]

    def _slip_of_curves(self, rows: Indices) -> Array:
        """Slip of the memory curves at rows, (n, k)."""
        followed = self._followed
        pieces, curves = followed.pieces.pieces_of_curves(followed.uppermost_piece[rows])
        profile_slips = self.series.contact.slip_integral(self._x, pieces.load[:, None])
        terms = [(self.series.unit_compliance * pieces.slope, profile_slips)]
        if np.any(pieces.parabola_slope) or np.any(pieces.fourth_slope):
            parabola_slips, fourth_slips = self._outside(followed.table.half_width(pieces.top))
            terms += [(pieces.parabola_slope, parabola_slips), (pieces.fourth_slope, fourth_slips)]
        return pieces.integrals_at_tops(*terms)[curves]

    def _of_bends(self, half_width: Array, bend: Array, fourth: Array) -> Array:
        """Traction within half-widths (n,) that bends x^2/2 and x^4/24 of gap or faces, times these
        numbers (n,), make: (n, k).
        """
        if not (np.any(bend) or np.any(fourth)):
            return np.zeros((len(half_width), len(self._x)))
        of_parabola, of_fourth = self._inside(half_width)
        return np.asarray(bend[:, None] * of_parabola + fourth[:, None] * of_fourth)

    def _inside(self, half_width: Array) -> tuple[Array, Array]:
        """Pressure of x^2/2, (E*/2) sqrt(a^2 - x^2), and of x^4/24, (E*/24) sqrt(a^2 - x^2) (a^2 +
        2 x^2): (n, k) each.
        """
        half_widths = half_width[:, None]
        root = np.sqrt(np.maximum((half_widths - self._x) * (half_widths + self._x), 0.0))
        pressure_of_parabola = self.series.modulus / 2 * root
        pressure_of_fourth = pressure_of_parabola * ((half_widths**2 + 2 * self._x**2) / 12)
        return pressure_of_parabola, pressure_of_fourth

    def _outside(self, half_width: Array) -> tuple[Array, Array]:
        """Integrals over flat punches that give the slip of a point outside of them, for a parabola
        and for x^4/24, (n, k) each [length^2, length^4].

        With c the half-width of a punch and a the upper limit `half_width` (n,), over c < min(a,
        |x|):

            int c arccosh(|x|/c) dc,    int (c^3/4) arccosh(|x|/c) dc

        Slip is such an integral times a slope of the memory curve, the locked-in tangential force
        over the half-width of the punches.
        """
        x = self._x
        inner_half_width = np.minimum(half_width[:, None], x)
        squared_width = inner_half_width**2
        root = np.sqrt(np.maximum(x**2 - squared_width, 0.0))
        arccosh_term = (
            np.arcsinh(root / np.where(inner_half_width > 0, inner_half_width, np.inf))
            * squared_width
        )
        slip_by_parabola = (arccosh_term + x * (x - root)) / 2
        slip_by_fourth = (
            squared_width * arccosh_term + x * (2 / 3 * x**3 - x**2 * root + root**3 / 3)
        ) / 16
        return np.asarray(slip_by_parabola), np.asarray(slip_by_fourth)


def _logarithms(table: PunchTable, s: Array, datum: float) -> PunchMoments:
    """Integrals of ln(2 L/c) up to the punches at s (k,), L = `datum` [length]."""
    load = table.load(s)
    log_ratio = math.log(2 * datum) - table.logarithm(s)
    return PunchMoments(
        profile=load * log_ratio + table.load_integral(s),
        parabola=table.parabola(s) * (log_ratio + 0.5),
        fourth=table.fourth(s) * (log_ratio + 0.25),
    )


# --------------------------------------------------------------------------------- the whole answer
@dataclass(frozen=True, eq=False)
class _Paths:
    """A path that was followed with the bodies, and with half-planes by the same steps.

    Attributes
    ----------
    question
        what is asked
    rows
        the steps
    bodies, half_planes
        what was followed
    steady_from
        first cycle that ends in the state it started from, None if none does
    covered
        for each whole cycle that the answer covers, the index of the followed cycle that it is
    """

    question: Question
    rows: PathRows
    bodies: PathSeries
    half_planes: PathSeries
    steady_from: int | None
    covered: tuple[int, ...]

    @property
    def last_cycle(self) -> slice:
        """Rows of the last covered cycle."""
        return self.rows.cycles[self.covered[-1]]

    @property
    def largest_half_width(self) -> float:
        """Of half-planes in the last covered cycle."""
        return float(np.max(self.half_planes.half_width[self.last_cycle]))

    @property
    def is_steady(self) -> bool:
        """Whether the last covered cycle ends in the state it started from."""
        return self.steady_from is not None and self.covered[-1] >= self.steady_from


def with_effects(question: Question) -> Findings:
    """Answer of half-plane theory corrected for finite bodies: fields, displacements, friction work
    and their errors along the load path of a question.

    Raises
    ------
    InputError
        For scenes with bulk stress, tilt or unequal sides of the profile, and for straight steps;
        for curvatures under which the contact would split or leave the profile.
    """
    _require_symmetric(question)
    with histories_kept():
        return _answer(question)


def _answer(question: Question) -> Findings:
    """Corrected half-plane answer to a question with a symmetric profile.

    The load path is followed with the finite bodies and with half-planes, by equal steps. Fields
    are those of the bodies; their tilt and bulk strain move the edges. The friction work is exact
    half-plane theory plus the difference between the two followed paths.
    """
    started = clock.perf_counter()
    paths = _followed(question)
    bodies = paths.bodies
    history_done = clock.perf_counter()

    x = question.x
    if x is None:
        x = mirrored_points(1.05 * float(np.max(bodies.half_width)))
    distance, number_of_distance = folded(x)
    time, row_numbers = instants_of(question, paths.rows, paths.last_cycle)
    points = PointFields(bodies, distance)
    fields_at_distances = grids_at(question, points, distance, row_numbers)
    tilt_and_strain = _odd_part(paths)
    series = series_at(question, bodies, row_numbers)
    contact_centres, stick_centres = tilt_and_strain.centres(paths.rows.time)
    series["contact_edges"] = series["contact_edges"] + contact_centres[row_numbers, None]
    series["stick_edges"] = series["stick_edges"] + stick_centres[row_numbers, None]
    fields_done = clock.perf_counter()

    friction_work = _work_of(paths, points, distance, tilt_and_strain)
    errors = friction_work.errors | _errors_of_steps(paths) | _errors_of_contact(paths)
    seconds = {"history": history_done - started, "fields": fields_done - history_done}
    seconds["dissipation"] = clock.perf_counter() - fields_done
    termination, message = _ending(paths)
    fields_at_points = {
        name: np.take(grid, number_of_distance, axis=1)
        for name, grid in fields_at_distances.items()
    }
    stick_half_width = permanent_stick(bodies, paths.last_cycle, stick_centres[paths.last_cycle])
    values: dict[str, Any] = {
        **series,
        **fields_at_points,
        "permanent_stick_half_width": stick_half_width,
        "dissipation": float(friction_work.cycles[-1]),
        "loop_work": friction_work.loop,
        "cycle_dissipation": friction_work.cycles,
        "dissipation_density": friction_work.density[number_of_distance],
        "steady_from": paths.steady_from,
    }
    return Findings(
        time=time,
        x=x,
        values=values,
        termination=termination,
        message=message,
        notes=tuple(_notes_of(paths, tilt_and_strain)),
        errors={name: error for name, error in errors.items() if error},
        certificates=certificates_of(bodies, fields_at_distances, row_numbers),
        counts={
            "points_evaluated": len(distance),
            "rows": len(paths.rows.time),
            "pieces": len(bodies.followed.pieces.top),
            "cycles_solved": len(paths.rows.cycles),
        },
        seconds=seconds,
    )


def _followed(question: Question) -> _Paths:
    """The load path of a question, followed twice by equal straight steps: with the curvatures of
    the finite bodies, and with half-planes.

    Returned with both are the steps, the first cycle that ends as it began, and which followed
    cycle stands for each cycle of the answer.
    """
    scene = question.scene
    effects = question.effects
    assert effects is not None  # for the type checker: the door took the other way
    path = path_of_question(replace(question, effects=None), None)
    route = _Route(scene, path)
    rows = route.first_rows(question.time)
    modulus = composite_modulus(scene.material)
    contact = contact_of(scene.profile, scene.material)
    curvatures = curvatures_of(effects)
    table = table_of(contact, modulus, rows, curvatures)
    friction = scene.friction.coefficient
    largest_parabola = float(table.parabola(table.largest_s))
    rows = route.with_turning_points(rows, friction, curvatures, largest_parabola)
    loads = (rows.normal_load, rows.tangential_load)
    memory_of_half_planes = follow(table, friction, *loads, Curvatures())
    memory_of_bodies = follow(table, friction, *loads, curvatures, memory_of_half_planes)
    steady_from = _steady_from(memory_of_bodies, rows, scene)
    return _Paths(
        question=question,
        rows=rows,
        bodies=PathSeries(memory_of_bodies, contact, modulus, effects),
        half_planes=PathSeries(memory_of_half_planes, contact, modulus, None),
        steady_from=steady_from,
        covered=_covered(question, route, steady_from),
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


def table_of(
    contact: SymmetricContact, modulus: float, rows: PathRows, curvatures: Curvatures
) -> PunchTable:
    """Table of the flat punches that make up the contact, wide enough for the largest contact of a
    load path, with the curvatures of finite bodies and without.

    The table is widened step by step until its punches carry the load P at every instant.
    Curvatures of the gap below zero widen the contact.

    Parameters
    ----------
    contact
        P(a) of the profile on half-planes
    modulus
        E* [stress]
    rows
        instants of the path with P and Q
    curvatures
        what P and Q add to the curvature of gap and faces

    Raises
    ------
    InputError
        Where that contact is wider than the profile, or where the bodies bend the faces away from
        each other so that the contact would split.
    """
    largest_load = float(np.max(rows.normal_load))
    largest_half_width = float(contact.half_width(largest_load))
    gap_curvature = curvatures.of_gap(rows.normal_load, rows.tangential_load)
    gap_fourth = curvatures.normal_fourth * rows.normal_load
    for _ in range(60):
        table = PunchTable(contact, modulus, min(largest_half_width * _BEYOND, contact.extent))
        # p_2 is at most that of a flat punch, P c^2/2.
        largest_moment = rows.normal_load * float(table.half_width(table.largest_s)) ** 2 / 2
        least_curvature = gap_curvature + 2 * min(curvatures.normal_mixed, 0.0) * largest_moment
        load_at_table_end = float(table.load(table.largest_s)) + least_curvature * float(
            table.parabola(table.largest_s)
        )
        load_at_table_end = load_at_table_end + gap_fourth * float(table.fourth(table.largest_s))
        if np.all(load_at_table_end >= rows.normal_load):
            break
        if largest_half_width >= contact.extent:
            raise InputError(
                "profile: with the curvature of the bodies the contact is wider than the profile,"
                f" {contact.extent:.6g}: state a wider profile or smaller loads"
            )
        largest_half_width *= _BEYOND
    else:
        raise splits()
    s_of_punches = np.linspace(1.0 if contact.least_half_width else 0.0, table.largest_s, 200)
    least_curvature_of_all = min(float(np.min(gap_curvature)), 0.0)
    if np.any(
        np.diff(table.load(s_of_punches) + least_curvature_of_all * table.parabola(s_of_punches))
        < 0
    ):
        raise splits()
    for row in {int(np.argmin(least_curvature)), int(np.argmin(gap_fourth))}:
        carried_load = table.load(s_of_punches) + least_curvature[row] * table.parabola(
            s_of_punches
        )
        if np.any(np.diff(carried_load + gap_fourth[row] * table.fourth(s_of_punches)) < 0):
            raise splits()
    return table


def splits() -> InputError:
    """Of bodies that bend the faces away from each other."""
    return InputError(
        "effects: the normal curvature is negative and larger than that of the profile: the contact"
        " would split, which corrected theory does not take"
    )


def _steady_from(followed: Followed, rows: PathRows, scene: Scene) -> int | None:
    """Index of the first cycle, 0 or 1, that leaves the friction state as it found it; None where
    neither does.

    The state is the memory curve, locked-in tangential force over half-width. Those at begin and
    end of the cycle must agree at 200 punches to 1e-9 of f P. A path without cycles counts as
    steady (0) if it ends unloaded.

    Parameters
    ----------
    followed
        memory curve at each instant
    rows
        the instants, with the loads there
    """
    if rows.period is None:
        return 0 if rows.normal_load[-1] <= 0 else None
    s_of_punches = np.linspace(0.0, followed.table.largest_s, 200)
    tolerance = _STEADY * followed.friction * float(np.max(rows.normal_load))
    forces_at_ends = [followed.locked_in_force(row, s_of_punches) for row in rows.ends]
    for cycle in range(min(len(rows.cycles), max(scene.cycles, 2))):
        if np.max(np.abs(forces_at_ends[cycle + 1] - forces_at_ends[cycle])) <= tolerance:
            return cycle
    return None


def _covered(question: Question, route: _Route, steady_from: int | None) -> tuple[int, ...]:
    """For each whole cycle of the answer, the index of the followed cycle that stands for it.

    Only two cycles are followed, the first and a steady one: index 0 or 1. Later cycles equal the
    second.

    Parameters
    ----------
    question
        how many cycles are wanted, or at which instants
    route
        the load path
    steady_from
        index of the first cycle that repeats; None where none was seen to
    """
    if route.period is None:
        return (0,)
    cycles = question.scene.cycles
    until_steady = 2 if steady_from is None else steady_from + 1
    _, whole_cycles = cycles_to_follow(route.cycle_ends[0], route.period, cycles, question.time)
    n_cycles = whole_cycles or min(cycles, until_steady)
    followed_cycles = tuple(min(k, 1) for k in range(n_cycles))
    if question.wants_last_cycle_alone:
        return followed_cycles[-1:]
    return followed_cycles


def instants_of(question: Question, rows: PathRows, last_cycle: slice) -> tuple[Array, Indices]:
    """Instants of the answer, (n,), and the number of the followed instant nearest to each, (n,).

    The instants are those of the question. Where it gives none, they are all followed instants, or
    those of the last cycle if only that is wanted.
    """
    if question.time is None:
        first_row = last_cycle.start if question.wants_last_cycle_alone else 0
        row_numbers = np.arange(first_row, last_cycle.stop)
        return rows.time[row_numbers], row_numbers
    time_in_path, _ = time_in_followed_path(
        question.time, float(rows.time[0]), float(rows.time[-1]), rows.period
    )
    row_after = np.clip(np.searchsorted(rows.time, time_in_path), 1, len(rows.time) - 1)
    is_before = time_in_path - rows.time[row_after - 1] < rows.time[row_after] - time_in_path
    return question.time, row_after - is_before


def series_at(question: Question, bodies: PathSeries, row_numbers: Indices) -> dict[str, Array]:
    """Values of the answer that have one number per instant, or one per edge, by their names.

    They are loads, displacements, contact and stick half-width (n,) and the edges (n, 2), left then
    right. Displacements that were not asked for are NaN.

    Parameters
    ----------
    bodies
        the followed path with the finite bodies
    row_numbers
        (n,) numbers of its instants
    """
    not_a_number = np.full(len(row_numbers), np.nan)
    displacement = not_a_number
    approach = not_a_number
    if question.wants("tangential_displacement"):
        displacement = bodies.tangential_displacement[row_numbers]
    if question.wants("normal_approach"):
        approach = bodies.normal_approach[row_numbers]
    half_width = bodies.half_width[row_numbers]
    stick_half_width = bodies.stick_half_width[row_numbers]
    sides = np.array([-1.0, 1.0])
    return {
        "normal_load": bodies.followed.normal_load[row_numbers],
        "tangential_load": bodies.followed.tangential_load[row_numbers],
        "tangential_displacement": displacement,
        "normal_approach": approach,
        "contact_half_width": half_width,
        "stick_half_width": stick_half_width,
        "contact_edges": half_width[:, None] * sides,
        "stick_edges": stick_half_width[:, None] * sides,
    }


def grids_at(
    question: Question, points: PointFields, distance: Array, row_numbers: Indices
) -> dict[str, NDArray[Any]]:
    """Fields of the answer at instants and points, by their names, (n, k) each: pressure and shear
    [stress], slip [length] and state of contact.

    A field that was not asked for is NaN; its state is "open".

    Parameters
    ----------
    points
        evaluates the fields of the followed path at the distances
    distance
        (k,) |x| [length] from the middle of contact
    row_numbers
        (n,) numbers of the instants of the path
    """
    shape = (len(row_numbers), len(distance))
    fields: dict[str, NDArray[Any]] = {
        name: np.broadcast_to(np.nan, shape) for name in ("pressure", "shear", "slip")
    }
    fields["state"] = np.broadcast_to(np.int8(OPEN), shape)
    if question.wants("pressure"):
        fields["pressure"] = points.pressure(row_numbers)
        if np.any(fields["pressure"] < 0):
            raise splits()
    if question.wants("shear"):
        fields["shear"] = points.shear(row_numbers)
    if question.wants("slip"):
        fields["slip"] = points.slip(row_numbers)
    if question.wants("state"):
        fields["state"] = _states(points, distance, row_numbers)
    return fields


def _states(points: PointFields, distance: Array, row_numbers: Indices) -> NDArray[np.int8]:
    """State of contact of each point at each instant, (n, k): open, stick, forward or reverse slip.

    A point slips in the zone at the edge of contact, or in an inner zone, which may slip in
    the other direction, or while the edge sticks.

    Parameters
    ----------
    points
        fields of the followed path at the distances
    distance
        (k,) |x| [length] from the middle
    row_numbers
        (n,) numbers of the instants
    """
    bodies = points.series
    history = bodies.followed
    sides = np.array([-1.0, 1.0])
    half_width = bodies.half_width[row_numbers, None]
    stick_edge = history.table.half_width(history.stick_edge[row_numbers])[:, None]
    inner_zone_ends = history.table.half_width(history.inner_zone[row_numbers])
    states_by_sense = np.array((SLIP_REVERSE, STICK, SLIP_FORWARD), dtype=np.int8)
    state_at_edge = states_by_sense[history.direction[row_numbers, None] + 1]
    state_in_inner_zone = states_by_sense[history.inner_zone_direction[row_numbers, None] + 1]
    # In full slip the stick edge is at 0: only x = 0 is within it, and that point slips.
    is_within_stick_edge = between(stick_edge * sides, distance) & (stick_edge > 0)
    states = np.where(is_within_stick_edge, np.int8(STICK), state_at_edge)
    is_in_inner_zone = (distance > inner_zone_ends[:, [0]]) & (distance < inner_zone_ends[:, [1]])
    states = np.where(is_in_inner_zone, state_in_inner_zone, states)
    for row_place, slip_zone in points.inner_slips(row_numbers):
        states_of_row = np.where(
            is_within_stick_edge[row_place], np.int8(STICK), state_at_edge[row_place]
        )
        state_of_zone = states_by_sense[slip_zone.sense + 1]
        states[row_place] = np.where(slip_zone.slips, state_of_zone, states_of_row)
    is_pressed = history.normal_load[row_numbers, None] > 0
    is_in_contact = between(half_width * sides, distance) & is_pressed
    return np.where(is_in_contact, states, np.int8(OPEN))


class _Work(NamedTuple):
    """Friction work of the covered cycles (c,), closed integral of the last, its W(x) (k,), NaN
    what is not wanted or known; relative errors by name.
    """

    cycles: Array
    loop: float
    density: Array
    errors: dict[str, float]


def _work_of(
    paths: _Paths, points: PointFields, distance: Array, tilt_and_strain: OddPart
) -> _Work:
    """Friction work of the cycles of the answer, its density W(x), and their relative errors.

    Each is that of exact half-plane theory plus a difference: the path with the finite bodies minus
    the path of half-planes, both by equal straight steps. The errors of the steps cancel in it.

    Parameters
    ----------
    points
        fields along the path with the bodies at the distances
    distance
        (k,) |x| [length] from the middle
    tilt_and_strain
        work that tilt and bulk strain of the bodies add
    """
    question = paths.question
    cycles = np.full(len(paths.covered), np.nan)
    loop = math.nan
    density = np.full(len(distance), np.nan)
    wanted_fields = question.fields & _OF_WORK
    errors: dict[str, float] = {}
    if not wanted_fields:
        return _Work(cycles, loop, density, errors)
    end_times = paths.rows.time[list(paths.rows.ends)]
    question_of_half_planes = replace(
        question,
        effects=None,
        fields=wanted_fields,
        x=distance,
        time=end_times,
        cycles="all",
    )
    theory = by_memory(question_of_half_planes, None)
    if question.wants("dissipation"):
        works_of_theory = np.asarray(theory.values["cycle_dissipation"])
        exact_works = works_of_theory[np.minimum(paths.covered, len(works_of_theory) - 1)]
        cycles, loop, errors = _works_of_cycles(paths, exact_works, tilt_and_strain)
        if "dissipation" in errors:
            errors["dissipation"] += theory.errors.get("dissipation", 0.0)
    if question.wants("dissipation_density"):
        exact_density = np.asarray(theory.values["dissipation_density"])
        density, density_error = _density_of(paths, points, distance, exact_density)
        if density_error is not None:
            errors["dissipation_density"] = density_error
    return _Work(cycles, loop, density, errors)


def _density_of(
    paths: _Paths, points: PointFields, distance: Array, exact_density: Array
) -> tuple[Array, float | None]:
    """Friction work per area W(x) of the last cycle, (k,), and its relative error.

    It is `exact_density` of half-plane theory plus the change that finite bodies make, by equal
    steps with and without them; 0 where the bodies do not slip. The error is over the largest W(x),
    None where nothing slips.

    Parameters
    ----------
    points
        fields along the path with the bodies
    distance
        (k,) |x| [length] from the middle
    exact_density
        (k,) W(x) of half-planes by exact theory
    """
    half_planes = paths.half_planes
    last_cycle = paths.last_cycle
    density_by_steps = PointFields(half_planes, distance).work(last_cycle)
    density_of_bodies = points.work(last_cycle)
    density = np.maximum(exact_density + density_of_bodies - density_by_steps, 0.0)
    density = np.where(density_of_bodies > 0, density, 0.0)
    largest_density = float(np.max(exact_density, initial=0.0))
    if not largest_density > 0:
        return density, None
    step_error = float(np.max(np.abs(density_by_steps - exact_density))) / largest_density
    if not half_planes.work(last_cycle) > 0:
        return density, step_error
    effects = paths.question.effects
    assert effects is not None  # for the type checker
    return density, step_error + left_of_work(paths.bodies, half_planes, last_cycle, effects)


def _works_of_cycles(
    paths: _Paths, exact_works: Array, tilt_and_strain: OddPart
) -> tuple[Array, float, dict[str, float]]:
    """Friction work of each cycle of the answer (c,), the work of the loads in the last cycle, and
    the relative errors of both by name.

    Friction work is that of half-planes plus what curvatures, tilt and bulk strain of finite bodies
    change. The work of the loads is the closed integral of Q dU + P d(approach); it equals the
    friction work where the cycle is steady, and is NaN where it cannot be compared.

    Parameters
    ----------
    exact_works
        (c,) work of these cycles by exact half-plane theory
    tilt_and_strain
        work that tilt and bulk strain add, or why it is left out
    """
    half_planes = paths.half_planes
    bodies = paths.bodies
    cycles = [paths.rows.cycles[k] for k in paths.covered]
    works_by_steps = np.array([half_planes.work(rows) for rows in cycles])
    works_of_bodies = np.array([bodies.work(rows) for rows in cycles])
    works_of_tilt_and_strain = [tilt_and_strain.work(k) for k in paths.covered]
    friction_works = exact_works + (works_of_bodies - works_by_steps)
    friction_works = friction_works + np.array([added.value for added in works_of_tilt_and_strain])

    # The displacements lack what tilt and bulk strain do to slip: no comparison with them.
    has_loop = (
        paths.question.wants("loop_work")
        and tilt_and_strain.answer is None
        and tilt_and_strain.on_grids is None
        and paths.is_steady
        and paths.rows.period is not None
    )
    loop_work = bodies.loop_work(paths.last_cycle) if has_loop else math.nan
    last_work = float(exact_works[-1])
    if last_work <= 0:
        return friction_works, loop_work, {}
    step_error = _OF_STEPS * abs(float(works_by_steps[-1]) / last_work - 1)
    step_error += (
        _OF_HALVED * abs(_work_of_halved_steps(paths) - float(works_of_bodies[-1])) / last_work
    )
    odd_error = works_of_tilt_and_strain[-1].uncertainty / last_work
    effects = paths.question.effects
    assert effects is not None  # for the type checker
    next_order_error = left_of_work(bodies, half_planes, paths.last_cycle, effects)
    errors = {"dissipation": step_error + odd_error + next_order_error}
    if tilt_and_strain.left_out:
        errors["dissipation"] = math.nan  # how much tilt and strain add is not known
    if has_loop:
        loop_of_half_planes = half_planes.loop_work(paths.last_cycle)
        errors["loop_work"] = abs(loop_of_half_planes / last_work - 1) + next_order_error
    return friction_works, loop_work, errors


def left_of_work(
    bodies: PathSeries, half_planes: PathSeries, rows: slice, effects: BodyEffects
) -> float:
    """Relative uncertainty of the friction work of a cycle, because the effects of finite bodies
    are cut after their next order.

    Each curvature changes the work of half-planes by some share. Of that change a known fraction
    may be missed. Curvatures that may cancel each other are followed one kind at a time.

    Parameters
    ----------
    bodies, half_planes
        the path followed with the finite bodies, and with half-planes
    rows
        instants of the cycle
    effects
        curvatures of the bodies
    """
    left_by_curvature = left_of_curvatures(effects, float(np.max(half_planes.half_width[rows])))
    work_of_half_planes = half_planes.work(rows)
    change_by_bodies = bodies.work(rows) / work_of_half_planes - 1
    curvatures = curvatures_of(effects)
    if curvatures.are_of_mirrored_bodies and curvatures.normal >= 0 and curvatures.tangential >= 0:
        # Both change W in one direction.
        return abs(change_by_bodies) * max(left_by_curvature.values()) + LEFT_IN_ANY_CASE
    followed = bodies.followed
    loads = (followed.normal_load, followed.tangential_load)
    uncertainty = LEFT_IN_ANY_CASE
    change_left = change_by_bodies
    for names in CURVATURES:
        curvatures_alone = curvatures_of(with_these_alone(effects, names))
        table_and_loads = (followed.table, followed.friction, *loads)
        memory_with_these = follow(*table_and_loads, curvatures_alone, half_planes.followed)
        work = bodies.unit_compliance * float(np.sum(memory_with_these.step_work[rows][1:]))
        change_by_these = work / work_of_half_planes - 1
        uncertainty += abs(change_by_these) * left_by_curvature[names]
        change_left -= change_by_these
    return uncertainty + abs(change_left) * sum(left_by_curvature.values())


def _errors_of_contact(paths: _Paths) -> dict[str, float]:
    """Relative errors of the largest pressure and of the contact half-width, because the effects of
    finite bodies are cut after their next order.

    Each error is a fraction of what the bodies change: the ratio of values with and without them,
    minus 1, at the largest load of the last cycle. Empty where there is no contact.
    """
    effects = paths.question.effects
    assert effects is not None  # for the type checker
    bodies = paths.bodies
    half_planes = paths.half_planes
    last_cycle = paths.last_cycle
    row_of_largest_load = np.array(
        [last_cycle.start + int(np.argmax(bodies.followed.normal_load[last_cycle]))]
    )
    largest_half_width = float(np.max(half_planes.half_width[last_cycle]))
    if not largest_half_width > 0:
        return {}
    places = largest_half_width * np.sin(np.linspace(0.0, math.pi / 2, _LOOKED_AT))
    pressures = [
        float(np.max(PointFields(series, places).pressure(row_of_largest_load)))
        for series in (bodies, half_planes)
    ]
    left_share = max(left_of_curvatures(effects, largest_half_width).values())
    pressure_change = abs(pressures[0] / pressures[1] - 1) if pressures[1] else 0.0
    half_width_change = abs(
        float(
            bodies.half_width[row_of_largest_load[0]]
            / half_planes.half_width[row_of_largest_load[0]]
        )
        - 1
    )
    return {
        "pressure": pressure_change * left_share + LEFT_IN_ANY_CASE,
        "contact_half_width": half_width_change * left_share + LEFT_IN_ANY_CASE,
    }


def _work_of_halved_steps(paths: _Paths) -> float:
    """Friction work of the last cycle [energy per thickness], after long steps in which the contact
    grows in stick are halved.

    In such a step the memory curve (locked-in tangential force over the half-width of punches)
    grows by a straight chord, which is an approximation. All other steps are exact however long
    they are. The change of work by halving gives the error.
    """
    followed = paths.bodies.followed
    effects = paths.question.effects
    assert effects is not None  # for the type checker
    n_rows = len(followed.normal_load)
    grows_in_stick = (np.diff(followed.edge) > 0) & (followed.direction[1:] == 0)
    load_growth = np.diff(followed.normal_load) / np.max(followed.normal_load)
    long_chords = np.flatnonzero(grows_in_stick & (load_growth > _SHORT_CHORD))
    if not len(long_chords):
        return paths.bodies.work(paths.last_cycle)
    row_places = np.union1d(np.arange(n_rows), long_chords + 0.5)
    normal_load, tangential_load = (
        np.interp(row_places, np.arange(n_rows), load)
        for load in (followed.normal_load, followed.tangential_load)
    )
    loads = (normal_load, tangential_load)
    memory_of_halved_steps = follow(
        followed.table, followed.friction, *loads, curvatures_of(effects)
    )
    first_row, row_beyond, _ = paths.last_cycle.indices(n_rows)
    is_of_cycle = (row_places > first_row) & (row_places <= row_beyond - 1)
    return paths.bodies.unit_compliance * float(
        np.sum(memory_of_halved_steps.step_work[is_of_cycle])
    )


def _odd_part(paths: _Paths) -> OddPart:
    """Work and shift of the edges that tilt and bulk strain of the finite bodies cause.

    Taken in the second order of these small numbers; where that does not hold, by a numerical
    solution on grids. Where neither works, the reason is returned instead of a number.
    """
    question = paths.question
    effects = question.effects
    assert effects is not None  # for the type checker
    if not any(getattr(effects, name).value for name in ODD_NUMBERS):
        return OddPart()
    try:
        tilt_and_strain = OddPart(odd_answer(question.scene, effects))
    except Declined as reason:
        if not question.wants("dissipation"):
            return OddPart(left_out=str(reason))
        work_of_bodies = paths.bodies.work(paths.last_cycle)
        tilt_and_strain = odd_part_on_grids(question.scene, effects, work_of_bodies, str(reason))
    work_of_half_planes = paths.half_planes.work(paths.last_cycle)
    if not work_of_half_planes > 0:
        return tilt_and_strain
    change_by_curvatures = paths.bodies.work(paths.last_cycle) / work_of_half_planes - 1
    ratio = ratio_of_next_order(effects, paths.largest_half_width)
    return tilt_and_strain._replace(left=left_of_tilt_and_strain(change_by_curvatures, ratio))


def odd_part_on_grids(scene: Scene, effects: BodyEffects, work: float, reason: str) -> OddPart:
    """Work that tilt and bulk strain of the finite bodies add, found by a numerical solution on
    grids.

    Grids give the relative change of the work of half-planes; it is applied to `work` [energy per
    thickness], that of the followed cycle. Used where the second order does not hold, for `reason`.
    Where grids refuse the scene or the change is too large, nothing is added and the reason stated.
    """
    try:
        half_plane_work = work_of_half_planes(scene)
        if not half_plane_work > 0:
            return OddPart(left_out=reason)  # nothing slips that could change
        change = change_by_tilt_and_strain(scene, effects)
    except InputError as fault:
        return OddPart(left_out=f"{reason}, and grids do not take it: {first_line(fault)}")
    if abs(change.value) > _MOST_ON_GRIDS:
        return OddPart(
            left_out=f"{reason}, and grids make them {100 * change.value:+.0f} % of the"
            " dissipation, which curvatures change too much"
        )
    return OddPart(on_grids=Estimate(change.value * work, change.uncertainty * work))


def _errors_of_steps(paths: _Paths) -> dict[str, float]:
    """Relative errors of shear and slip that the straight steps of the path cause, by field name.

    Measured on half-planes, for which exact theory exists: the largest difference between both at
    some instants and points. Points within 1 % of a half-width from an edge are left out. It is
    divided by the largest f p (shear) or the largest slip.
    """
    question = paths.question
    half_planes = paths.half_planes
    field_names = tuple(name for name in ("shear", "slip") if question.wants(name))
    friction = half_planes.followed.friction
    if not field_names or not friction:
        return {}
    last_cycle = paths.last_cycle
    row_numbers = np.unique(
        np.linspace(last_cycle.start, last_cycle.stop - 1, _INSTANTS).astype(int)
    )
    places = np.linspace(0.0, float(np.max(half_planes.half_width[row_numbers])), _PLACES)[1:]
    theory = by_memory(
        replace(
            question,
            effects=None,
            fields=frozenset(field_names),
            x=places,
            time=paths.rows.time[row_numbers],
            cycles="all",
        ),
        None,
    )
    points = PointFields(half_planes, places)
    pressure = points.pressure(row_numbers)
    largest_pressure = float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
    half_width = half_planes.half_width[row_numbers, None]
    stick_half_width = np.nan_to_num(half_planes.stick_half_width[row_numbers, None])
    is_away = (np.abs(places - half_width) > _NEAR * half_width) & (
        np.abs(places - stick_half_width) > _NEAR * half_width
    )
    fields_by_steps = {"shear": points.shear, "slip": points.slip}
    errors = {}
    for name in field_names:
        exact_values = theory.values[name]
        difference = np.where(
            is_away, np.abs(fields_by_steps[name](row_numbers) - exact_values), 0.0
        )
        scale = (
            friction * largest_pressure if name == "shear" else float(np.max(np.abs(exact_values)))
        )
        if scale > 0:
            errors[name] = float(np.max(difference)) / scale
    return errors


def permanent_stick(bodies: PathSeries, rows: slice, centre: Array | float = 0.0) -> float:
    """Half-width of the zone that sticks all through a cycle; NaN where no point does.

    Parameters
    ----------
    rows
        instants of the cycle
    centre
        (n,) centre of the stick zone at these instants [length]
    """
    stick = np.nan_to_num(np.minimum(bodies.stick_half_width, bodies.half_width)[rows])
    half_width = float(np.min(centre + stick) - np.max(centre - stick)) / 2
    return half_width if half_width > 0 and np.all(stick > 0) else math.nan


def _reference_load(scene: Scene, normal_load: Array) -> float:
    """Mean load of an ellipse, else the largest of the last cycle."""
    if scene.load.kind == "ellipse":
        return float(np.max(normal_load) + np.min(normal_load)) / 2
    return float(np.max(normal_load))


def _ending(paths: _Paths) -> tuple[str, str]:
    """How a path ended, in a word and in a sentence."""
    if paths.rows.period is None:
        return "end of path", "the path was followed to its end"
    if paths.steady_from is None:
        return "end of path", f"no steady cycle among the first {len(paths.rows.cycles)}"
    return "steady", f"cycle {paths.steady_from + 1} ends in the state it started from"


def _notes_of(paths: _Paths, odd: OddPart) -> Iterator[str]:
    """Sentences on what a reader of the answer must not miss: which effects of finite bodies are in
    it, what is left out, and why the loop of Q over U is not compared with the friction work.

    `odd` is what tilt and bulk strain of the bodies add.
    """
    question = paths.question
    scene = question.scene
    assert question.effects is not None  # for the type checker
    yield from neglected_coupling(scene.material)
    load = _reference_load(scene, paths.rows.normal_load[paths.last_cycle])
    half_width = float(paths.bodies.contact.half_width(load))
    modulus = composite_modulus(scene.material)
    yield from notes_of_effects(question.effects, half_width, modulus, odd)
    if odd.answer is not None or odd.on_grids is not None:
        yield (
            "no closed integral of Q dU to compare the dissipation with: displacements are without"
            " what tilt and bulk strain do to slip"
        )
    if question.wants("dissipation") and paths.rows.period is not None and not paths.is_steady:
        yield (
            "the last cycle is not steady: no closed integral of Q dU to compare the dissipation"
            " with"
        )


def certificates_of(
    bodies: PathSeries, grids: Mapping[str, NDArray[Any]], row_numbers: Indices
) -> dict[str, Array]:
    """Checks of the laws of contact along a followed path, by name, (n,) each, 0 where satisfied.

        tangential_balance    |M - Q| / (f times the largest P)
        cone                  the largest |q| - f p over the points, over f times the largest p

    M is the tangential force that the memory curve carries up to the edge of contact. The Coulomb
    limit ("cone") is checked where both pressure and shear were asked for.

    Parameters
    ----------
    bodies
        the path followed with the finite bodies
    grids
        pressure and shear at instants and points, (n, k) each
    row_numbers
        (n,) numbers of those instants
    """
    followed = bodies.followed
    friction = followed.friction
    largest_friction_force = max(
        friction * float(np.max(followed.normal_load)), np.finfo(float).tiny
    )
    force_of_curve = followed.pieces.force[followed.uppermost_piece[row_numbers]]
    edge_parabola = followed.table.parabola(followed.edge[row_numbers])
    carried_shear = force_of_curve + followed.tangential_curvature[row_numbers] * edge_parabola
    edge_fourth = followed.table.fourth(followed.edge[row_numbers])
    carried_shear = carried_shear + followed.tangential_fourth[row_numbers] * edge_fourth
    is_pressed = followed.normal_load[row_numbers] > 0
    balance = np.where(
        is_pressed, np.abs(carried_shear - followed.tangential_load[row_numbers]), 0.0
    )
    checks = {"tangential_balance": balance / largest_friction_force}
    pressure = grids["pressure"]
    shear = grids["shear"]
    if np.any(np.isfinite(pressure)) and np.any(np.isfinite(shear)):
        with np.errstate(invalid="ignore"):
            excess_of_shear = np.abs(shear) - friction * pressure
        limit = friction * float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
        excess_of_instant = np.fmax.reduce(excess_of_shear, axis=1, initial=0.0)
        checks["cone"] = excess_of_instant / max(limit, np.finfo(float).tiny)
    return checks
