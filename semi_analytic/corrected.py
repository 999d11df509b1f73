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
from semi_analytic.history import History, histories_kept, turns_of, within
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
    """What the bodies add to the curvature of gap and faces, per load."""
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
    """What of the effects is in the values, and what is not."""
    yield f"effects: {in_answer.even} of the bodies are in these values"
    numbers = odd_part(effects, half_width, modulus)
    if not any(numbers):
        return
    values = ", ".join(f"{value:.3g}" for value in numbers)
    symbols = f"o = (alpha_P, alpha_Q, e_P, e_Q) P0/(a0/R) = ({values})"
    if odd.answer is not None or odd.on_grids is not None:
        added = odd.work(-1)
        how = "in the second order" if odd.on_grids is None else "on grids"
        yield (
            f"effects: tilt and bulk strain of the bodies, {symbols}, add {added.value:.3g}"
            f" ± {added.uncertainty:.1g} to the dissipation, {how}, and"
            f" {in_answer.covered}"
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
        f" {symbols}, {consequence}{reason}"
    )


def notes_of_batch(effects: BodyEffects) -> Iterator[str]:
    """The same of a batch, whose members have different half-widths."""
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
    def marks(self) -> list[float]:
        """Ends of the initial loading and of two cycles; start and end of a path without cycle."""
        end = float(self.instants[-1])
        if self.period is None:
            return [self.start, end]
        cycle_start = end - len(self.path.cycles) * self.period
        return [cycle_start + k * self.period for k in range(3)]

    def rows(self, time: Array) -> PathRows:
        """Rows at instants (n,) and at the marks."""
        marks = self.marks
        length = marks[-1] - self.start
        inside = time[(time > self.start) & (time < marks[-1])]
        # Of two instants that are one a mark stays.
        distance = np.min(np.abs(inside[:, None] - np.array([self.start, *marks])), axis=1)
        inside = inside[distance > _SAME * length]
        instants = np.unique(np.concatenate([inside, [self.start], marks]))
        instants = instants[np.diff(instants, prepend=-np.inf) > _SAME * length]
        if len(instants) > _MOST_ROWS:
            raise InputError(
                f"effects: the load path has {len(instants):,} rows and corrected theory follows"
                f" {_MOST_ROWS:,} at most: take a part of the path, or half-planes without effects"
            )
        if isinstance(self.path, LoadSeries):
            normal_load, tangential_load = _loads_of_series(self.path, instants)
        else:
            normal_load, tangential_load = self.scene.load.path().at(instants)
        ends = tuple(int(np.argmin(np.abs(instants - mark))) for mark in marks)
        if self.period is None:
            ends = ends[1:]
        pressing = np.maximum(normal_load, 0.0)
        return PathRows(instants, pressing, tangential_load, ends, self.period)

    def first_rows(self, time: Array | None) -> PathRows:
        """Rows at theory's own instants, in both cycles, and at those that are asked for."""
        instants = self.instants
        marks = self.marks
        if self.period is not None:
            solved = len(self.path.cycles)
            last_cycle = instants[instants >= marks[0] + (solved - 1) * self.period]
            last_cycle = last_cycle - (solved - 1) * self.period
            instants = np.concatenate([instants, last_cycle, last_cycle + self.period])
        if time is not None:
            asked_for, _ = within(time, self.start, marks[-1], self.period)
            instants = np.append(instants, np.clip(asked_for, self.start, marks[-1]))
        return self.rows(instants)

    def with_turning_points(
        self, rows: PathRows, friction: float, curvatures: Curvatures, parabola: float
    ) -> PathRows:
        """Rows with the instants at which a bound B_s turns round, for some punches up to the
        largest, whose G is `parabola`: half-planes turn round at other instants.
        """
        if isinstance(self.path, LoadSeries):
            return rows
        normal_load = rows.normal_load
        tangential_load = rows.tangential_load
        gap_bend = curvatures.of_gap(normal_load, tangential_load)
        face_bend = curvatures.of_faces(normal_load, tangential_load)
        turning = []
        for direction in (1, -1):
            of_loads = tangential_load - direction * friction * normal_load
            of_bends = direction * friction * gap_bend - face_bend
            for share in _SHARES:
                bound = of_loads + share * parabola * of_bends
                turning.append(_turning_points(rows.time, bound))
        instants = np.concatenate(turning)
        after = np.clip(np.searchsorted(rows.time, instants), 1, len(rows.time) - 1)
        step = rows.time[after] - rows.time[after - 1]
        share = (instants - rows.time[after - 1]) / step
        is_between = (share > _BESIDE) & (share < 1 - _BESIDE)
        return self.rows(np.concatenate([rows.time, instants[is_between]]))


def _turning_points(time: Array, values: Array) -> Array:
    """Vertices of parabolas through three rows each, where values (n,) over time (n,) turn."""
    rise = np.diff(values)
    step = np.diff(time)
    slope = rise / step
    turns = np.flatnonzero(slope[1:] * slope[:-1] < 0) + 1
    middle = (step[turns - 1] + step[turns]) / 2
    bend = (slope[turns] - slope[turns - 1]) / middle
    return np.asarray((time[turns - 1] + time[turns]) / 2 - slope[turns - 1] / bend)


def _loads_of_series(series: LoadSeries, time: Array) -> tuple[Array, Array]:
    """P and Q on straight steps at instants (n,), also in cycles after those that were followed."""
    rows = np.concatenate([part.rows + np.array([part.delay, 0.0, 0.0]) for part in series.parts])
    inside = time
    if series.period is not None:
        end = float(rows[-1, 0])
        late = np.maximum(np.ceil((time - end) / series.period - _SAME), 0.0)
        inside = time - late * series.period
    return np.interp(inside, rows[:, 0], rows[:, 1]), np.interp(inside, rows[:, 0], rows[:, 2])


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
    way
        (n,) how far the bodies slid as a whole or moved while apart; None: they never did
    """

    followed: Followed
    contact: SymmetricContact
    modulus: float
    effects: BodyEffects | None
    way: Array | None = None

    @property
    def unit(self) -> float:
        """A/pi."""
        return 2 / (math.pi * self.modulus)

    @cached_property
    def half_width(self) -> Array:
        """a, (n,)."""
        half = self.followed.table.half_width(self.followed.edge)
        return np.where(self.followed.normal_load > 0, half, self.contact.least)

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
        """U, (n,)."""
        _, shear_logarithm = self._logarithms
        displacement = self.unit * shear_logarithm
        if self.way is not None:
            displacement = displacement + self.way
        if self.effects is None:
            return displacement
        bend = curvatures_of(self.effects)
        followed = self.followed
        of_moments = bend.tangential * followed.shear_second
        of_moments = of_moments + bend.normal_under_shear * followed.pressure_second
        if bend.tangential_fourth:
            of_moments = of_moments + bend.tangential_fourth * followed.shear_fourth / 12
        of_load = self.effects.tangential_compliance.value * self.followed.tangential_load
        of_tilt, _ = self._moved_by_tilt
        return np.asarray(displacement + of_load + of_moments / 2 + of_tilt)

    @cached_property
    def normal_approach(self) -> Array:
        """Normal approach, (n,)."""
        pressure_logarithm, _ = self._logarithms
        approach = self.unit * pressure_logarithm
        if self.effects is None:
            return approach
        bend = curvatures_of(self.effects)
        followed = self.followed
        of_moments = bend.normal * followed.pressure_second
        of_moments = of_moments + bend.tangential_under_pressure * followed.shear_second
        if bend.normal_fourth:
            of_moments = of_moments + bend.normal_fourth * followed.pressure_fourth / 12
        of_load = self.effects.normal_compliance.value * self.followed.normal_load
        _, of_tilt = self._moved_by_tilt
        return np.asarray(approach + of_load + of_moments / 2 + of_tilt)

    @cached_property
    def _moved_by_tilt(self) -> tuple[Array, Array]:
        """What the tilt of a parabola adds to U and the approach, (n,) each; 0 of other profiles.

        Tilted by alpha = alpha_P P + alpha_Q Q the contact sits about -alpha R, so that the moment
        of the pressure is M = -R alpha P; by reciprocity it moves the bodies by alpha_Q M and
        alpha_P M, and a tilted parabola is pressed in by R alpha^2/2 less.
        """
        load = self.followed.normal_load
        none = np.zeros(len(load))
        if self.effects is None or not isinstance(self.contact, HertzContact):
            return none, none
        under_pressure = self.effects.tilt_under_pressure.value
        under_shear = self.effects.tilt_under_shear.value
        tilt = under_pressure * load + under_shear * self.followed.tangential_load
        moment = -self.contact.radius * tilt * load
        pressed_less = self.contact.radius * tilt**2 / 2
        return under_shear * moment, under_pressure * moment - pressed_less

    @cached_property
    def _logarithms(self) -> tuple[Array, Array]:
        """int ln(2 L/c) dP and dM over the punches, (n,) each."""
        followed = self.followed
        datum = self.contact.datum_length if self.effects is None else self.effects.datum_length
        at_tops = _logarithms(followed.table, followed.pieces.top, datum)
        at_edge = _logarithms(followed.table, followed.edge, datum)
        return followed.of_pressure(at_edge), followed.of_shear(at_tops, at_edge)

    @cached_property
    def _inner_senses(self) -> Indices:
        """Sense of slip, (n,), at rows at which |q| of the memory curve is beyond f p; else 0."""
        followed = self.followed
        senses = np.zeros(len(followed.edge), dtype=np.int64)
        added = (
            followed.normal_curvature,
            followed.tangential_curvature,
            followed.normal_fourth,
            followed.tangential_fourth,
        )
        if not np.any(added):
            return senses
        largest_load = np.array([np.argmax(followed.normal_load)])
        middle = PointFields(self, np.zeros(1))
        allowed = _BEYOND_LIMIT * followed.friction * float(middle.pressure(largest_load)[0, 0])
        # A hundredth of it at some places, at a row or next to it, shows where to look closer.
        largest_excess, _ = self._beyond_limit(np.arange(len(senses)), _LOOKED_AT_FIRST)
        is_suspect = (largest_excess > allowed / 100).astype(float)
        closer = np.flatnonzero(np.convolve(is_suspect, np.ones(5), mode="same"))
        largest_excess, sense = self._beyond_limit(closer, _LOOKED_AT)
        senses[closer] = np.where(largest_excess > allowed, sense, 0)
        return senses

    def _beyond_limit(self, rows: Indices, count: int) -> tuple[Array, Array]:
        """Largest |q| - f p of the memory curve at so many places, and the sign of q there, at rows
        (n,): (n,) each.
        """
        shares = np.sin(np.linspace(0.0, math.pi / 2, count))
        points = PointFields(self, float(np.max(self.half_width)) * shares)
        largest_excess = np.zeros(len(rows))
        sense = np.zeros(len(rows))
        for begin in range(0, len(rows), _AT_ONCE):
            block = slice(begin, begin + _AT_ONCE)
            shear = points.shear_of_memory(rows[block])
            limit = self.followed.friction * points.pressure(rows[block])
            excess = np.nan_to_num(np.abs(shear) - limit)
            place = np.argmax(excess, axis=1)[:, None]
            largest_excess[block] = np.take_along_axis(excess, place, axis=1)[:, 0]
            sense[block] = np.sign(np.take_along_axis(shear, place, axis=1)[:, 0])
        return largest_excess, sense

    @cached_property
    def _inner_slips(self) -> dict[int, InnerSlip]:
        """What was worked out at rows."""
        return {}

    def inner_slips(self, rows: Indices) -> Iterator[tuple[int, InnerSlip]]:
        """What slips further at those of some rows at which |q| of the memory curve is beyond f p,
        with the number of the row among them.
        """
        for number in np.flatnonzero(self._inner_senses[rows]).tolist():
            row = int(rows[number])
            if row not in self._inner_slips:
                self._inner_slips[row] = self._inner_slip(row)
            yield number, self._inner_slips[row]

    def _inner_slip(self, row: int) -> InnerSlip:
        """What slips further at a row."""
        followed = self.followed

        def tractions(x: Array) -> tuple[Array, Array]:
            points = PointFields(self, x)
            return points.shear_at(row), followed.friction * points.pressure(np.array([row]))[0]

        half_width = float(self.half_width[row])
        front, *ring = followed.table.half_width([followed.front[row], *followed.ring[row]])
        edge_of_stick = front if followed.direction[row] else half_width
        ends = np.array([front, *ring])
        sense = int(self._inner_senses[row])
        return inner_slip(tractions, sense, half_width, ends, edge_of_stick, self.modulus)

    def loop_work(self, rows: slice) -> float:
        """Closed integral of Q dU + P d(approach) over a cycle."""
        followed = self.followed
        tangential = area_of_loop(
            followed.tangential_load[rows], self.tangential_displacement[rows]
        )
        return tangential + area_of_loop(followed.normal_load[rows], self.normal_approach[rows])

    def work(self, rows: slice) -> float:
        """Friction work of the steps of a cycle, or of the path."""
        return self.unit * float(np.sum(self.followed.step_work[rows][1:]))


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
        of_profile = self.series.contact.pressure(self._x, profile_load)
        bend = followed.normal_curvature[rows]
        fourth = followed.normal_fourth[rows]
        return of_profile + self._of_bends(self.series.half_width[rows], bend, fourth)

    def shear(self, rows: Indices) -> Array:
        """q, (n, k)."""
        shear = self.shear_of_memory(rows)
        for number, further in self.inner_slips(rows):
            shear[number] += further.shear
        return shear

    def shear_of_memory(self, rows: Indices) -> Array:
        """q without what slips further inside the contact, (n, k)."""
        followed = self._followed
        bend = followed.tangential_curvature[rows]
        fourth = followed.tangential_fourth[rows]
        following = self._of_bends(self.series.half_width[rows], bend, fourth)
        return self._shear_of_curves(rows) + following

    def shear_at(self, row: int) -> Array:
        """The same at one row, (k,): of its memory curve alone."""
        pieces = self._followed.pieces
        chain = pieces.chain(int(self._followed.curve[row]))
        half_widths = self._followed.table.half_width(pieces.top[chain])
        of_profile = self.series.contact.pressure_rise(self._x, pieces.load[chain, None])
        of_parabola, of_fourth = self._inside(half_widths)
        shear = pieces.slope[chain[1:]] @ np.diff(of_profile, axis=0)
        shear = shear + pieces.parabola_slope[chain[1:]] @ np.diff(of_parabola, axis=0)
        shear = shear + pieces.fourth_slope[chain[1:]] @ np.diff(of_fourth, axis=0)
        bend = self._followed.tangential_curvature[[row]]
        fourth = self._followed.tangential_fourth[[row]]
        following = self._of_bends(self.series.half_width[[row]], bend, fourth)
        return np.asarray(shear + following[0])

    def slip(self, rows: Indices) -> Array:
        """s, (n, k)."""
        known_rows, known_slip = self._known_slip
        if len(known_rows):
            place = np.minimum(np.searchsorted(known_rows, rows), len(known_rows) - 1)
            if np.array_equal(known_rows[place], rows):
                return known_slip[place]
        slip = self._slip(rows)
        if np.all(np.diff(rows) > 0):
            self._known_slip = (rows, slip)
        return slip

    def _slip(self, rows: Indices) -> Array:
        followed = self._followed
        slip = self._slip_of_curves(rows)
        # Inside the contact what sticks follows the curvature of the faces; outside it does not.
        bend = followed.tangential_curvature[rows, None]
        fourth = followed.tangential_fourth[rows, None]
        if np.any(bend) or np.any(fourth):
            of_parabola, of_fourth = self._outside(self.series.half_width[rows])
            slip = slip + bend * (of_parabola - self._x**2 / 2)
            slip = slip + fourth * (of_fourth - self._x**4 / 24)
        if self.series.way is not None:
            slip = slip + self.series.way[rows, None]
        for number, further in self.inner_slips(rows):
            slip[number] += further.slip
        return np.asarray(slip)

    def inner_slips(self, rows: Indices) -> Iterator[tuple[int, SlipAtPoints]]:
        """What slips further at some rows, as of the path, at the points."""
        for number, further in self.series.inner_slips(rows):
            row = int(rows[number])
            if row not in self._inner_slips:
                self._inner_slips[row] = further.at(self._x)
            yield number, self._inner_slips[row]

    @cached_property
    def _inner_slips(self) -> dict[int, SlipAtPoints]:
        """What was worked out at rows."""
        return {}

    def work(self, rows: slice) -> Array:
        """W(x) of the steps of a cycle, (k,)."""
        numbers = np.arange(len(self._followed.edge))[rows]
        limit = self._followed.friction * self.pressure(numbers)
        limit = np.where(np.isfinite(limit), limit, 0.0)
        mean_limit = (limit[1:] + limit[:-1]) / 2
        distance = np.abs(np.diff(self.slip(numbers), axis=0))
        stick = np.nan_to_num(self.series.stick_half_width[numbers])
        least_stick = np.minimum(stick[1:], stick[:-1])[:, None]
        slips = self._followed.sense[numbers[1:], None] != 0
        is_rubbed = slips & (self._x >= least_stick)
        return np.asarray(np.sum(np.where(is_rubbed, mean_limit * distance, 0.0), axis=0))

    def _shear_of_curves(self, rows: Indices) -> Array:
        """Shear of the memory curves at rows, (n, k)."""
        followed = self._followed
        pieces, curves = followed.pieces.of_curves(followed.curve[rows])
        of_profile = self.series.contact.pressure_rise(self._x, pieces.load[:, None])
        terms = [(pieces.slope, of_profile)]
        if np.any(pieces.parabola_slope) or np.any(pieces.fourth_slope):
            of_parabola, of_fourth = self._inside(followed.table.half_width(pieces.top))
            terms += [(pieces.parabola_slope, of_parabola), (pieces.fourth_slope, of_fourth)]
        return pieces.sums(*terms)[curves]

    def _slip_of_curves(self, rows: Indices) -> Array:
        """Slip of the memory curves at rows, (n, k)."""
        followed = self._followed
        pieces, curves = followed.pieces.of_curves(followed.curve[rows])
        of_profile = self.series.contact.slip_integral(self._x, pieces.load[:, None])
        terms = [(self.series.unit * pieces.slope, of_profile)]
        if np.any(pieces.parabola_slope) or np.any(pieces.fourth_slope):
            of_parabola, of_fourth = self._outside(followed.table.half_width(pieces.top))
            terms += [(pieces.parabola_slope, of_parabola), (pieces.fourth_slope, of_fourth)]
        return pieces.sums(*terms)[curves]

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
        half = half_width[:, None]
        root = np.sqrt(np.maximum((half - self._x) * (half + self._x), 0.0))
        of_parabola = self.series.modulus / 2 * root
        of_fourth = of_parabola * ((half**2 + 2 * self._x**2) / 12)
        return of_parabola, of_fourth

    def _outside(self, half_width: Array) -> tuple[Array, Array]:
        """(A/pi) int arccosh(|x|/c) dG and dG_4 over c < min(a, |x|), int c arccosh(|x|/c) dc and
        int (c^3/4) arccosh(|x|/c) dc: (n, k) each.
        """
        x = self._x
        inner = np.minimum(half_width[:, None], x)
        square = inner**2
        root = np.sqrt(np.maximum(x**2 - square, 0.0))
        arc = np.arcsinh(root / np.where(inner > 0, inner, np.inf)) * square
        of_parabola = (arc + x * (x - root)) / 2
        of_fourth = (square * arc + x * (2 / 3 * x**3 - x**2 * root + root**3 / 3)) / 16
        return np.asarray(of_parabola), np.asarray(of_fourth)


def _logarithms(table: PunchTable, s: Array, datum: float) -> PunchMoments:
    """Integrals of ln(2 L/c) up to the punches at s (k,), L = `datum` [length]."""
    load = table.load(s)
    log_ratio = math.log(2 * datum) - table.logarithm(s)
    return PunchMoments(
        profile=load * log_ratio + table.log_area(s),
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
    """The answer with the effects of the bodies.

    Raises
    ------
    InputError
        For scenes with bulk stress, tilt or unequal sides of the profile, and `straight_steps`; for
        curvatures under which the contact would split or leave the profile.
    """
    _require_symmetric(question)
    with histories_kept():
        return _answer(question)


def _answer(question: Question) -> Findings:
    """The same, of what corrected theory takes."""
    started = clock.perf_counter()
    paths = _followed(question)
    bodies = paths.bodies
    history_done = clock.perf_counter()

    x = question.x
    if x is None:
        x = mirrored_points(1.05 * float(np.max(bodies.half_width)))
    distance, fold = folded(x)
    time, numbers = instants_of(question, paths.rows, paths.last_cycle)
    points = PointFields(bodies, distance)
    grids = grids_at(question, points, distance, numbers)
    odd = _odd_part(paths)
    series = series_at(question, bodies, numbers)
    of_contact, of_stick = odd.centres(paths.rows.time)
    series["contact_edges"] = series["contact_edges"] + of_contact[numbers, None]
    series["stick_edges"] = series["stick_edges"] + of_stick[numbers, None]
    fields_done = clock.perf_counter()

    work = _work_of(paths, points, distance, odd)
    errors = work.errors | _errors_of_steps(paths) | _errors_of_contact(paths)
    seconds = {"history": history_done - started, "fields": fields_done - history_done}
    seconds["dissipation"] = clock.perf_counter() - fields_done
    termination, message = _ending(paths)
    values: dict[str, Any] = {
        **series,
        **{name: np.take(grid, fold, axis=1) for name, grid in grids.items()},
        "permanent_stick_half_width": permanent_stick(
            bodies, paths.last_cycle, of_stick[paths.last_cycle]
        ),
        "dissipation": float(work.cycles[-1]),
        "loop_work": work.loop,
        "cycle_dissipation": work.cycles,
        "dissipation_density": work.density[fold],
        "steady_from": paths.steady_from,
    }
    return Findings(
        time=time,
        x=x,
        values=values,
        termination=termination,
        message=message,
        notes=tuple(_notes_of(paths, odd)),
        errors={name: error for name, error in errors.items() if error},
        certificates=certificates_of(bodies, grids, numbers),
        counts={
            "points_evaluated": len(distance),
            "rows": len(paths.rows.time),
            "pieces": len(bodies.followed.pieces.top),
            "cycles_solved": len(paths.rows.cycles),
        },
        seconds=seconds,
    )


def _followed(question: Question) -> _Paths:
    """The path of a question, followed twice."""
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
    largest_parabola = float(table.parabola(table.last))
    rows = route.with_turning_points(rows, friction, curvatures, largest_parabola)
    loads = (rows.normal_load, rows.tangential_load)
    without = follow(table, friction, *loads, Curvatures())
    with_bodies = follow(table, friction, *loads, curvatures, without)
    steady_from = _steady_from(with_bodies, rows, scene)
    return _Paths(
        question=question,
        rows=rows,
        bodies=PathSeries(with_bodies, contact, modulus, effects),
        half_planes=PathSeries(without, contact, modulus, None),
        steady_from=steady_from,
        covered=_covered(question, route, steady_from),
    )


def _require_symmetric(question: Question) -> None:
    """InputError for what corrected theory does not take."""
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
    """Punches up to the largest contact, with the bodies and without.

    Raises
    ------
    InputError
        Where that is beyond the profile, or where the bodies bend the faces away from each other.
    """
    largest_load = float(np.max(rows.normal_load))
    largest = float(contact.half_width(largest_load))
    bend = curvatures.of_gap(rows.normal_load, rows.tangential_load)
    fourth = curvatures.normal_fourth * rows.normal_load
    for _ in range(60):
        table = PunchTable(contact, modulus, min(largest * _BEYOND, contact.extent))
        # p_2 is at most that of a flat punch, P c^2/2.
        most_moment = rows.normal_load * float(table.half_width(table.last)) ** 2 / 2
        least_bend = bend + 2 * min(curvatures.normal_mixed, 0.0) * most_moment
        at_end = float(table.load(table.last)) + least_bend * float(table.parabola(table.last))
        at_end = at_end + fourth * float(table.fourth(table.last))
        if np.all(at_end >= rows.normal_load):
            break
        if largest >= contact.extent:
            raise InputError(
                "profile: with the curvature of the bodies the contact is wider than the profile,"
                f" {contact.extent:.6g}: state a wider profile or smaller loads"
            )
        largest *= _BEYOND
    else:
        raise splits()
    s = np.linspace(1.0 if contact.least else 0.0, table.last, 200)
    least = min(float(np.min(bend)), 0.0)
    if np.any(np.diff(table.load(s) + least * table.parabola(s)) < 0):
        raise splits()
    for row in {int(np.argmin(least_bend)), int(np.argmin(fourth))}:
        carried = table.load(s) + least_bend[row] * table.parabola(s)
        if np.any(np.diff(carried + fourth[row] * table.fourth(s)) < 0):
            raise splits()
    return table


def splits() -> InputError:
    """Of bodies that bend the faces away from each other."""
    return InputError(
        "effects: the normal curvature is negative and larger than that of the profile: the contact"
        " would split, which corrected theory does not take"
    )


def _steady_from(followed: Followed, rows: PathRows, scene: Scene) -> int | None:
    """The first cycle that ends in the state it started from: the first or the second."""
    if rows.period is None:
        return 0 if rows.normal_load[-1] <= 0 else None
    s = np.linspace(0.0, followed.table.last, 200)
    allowed = _STEADY * followed.friction * float(np.max(rows.normal_load))
    states = [followed.frozen_force(row, s) for row in rows.ends]
    for number in range(min(len(rows.cycles), max(scene.cycles, 2))):
        if np.max(np.abs(states[number + 1] - states[number])) <= allowed:
            return number
    return None


def _covered(question: Question, route: _Route, steady_from: int | None) -> tuple[int, ...]:
    """For each whole cycle that the answer covers, the index of the followed cycle that it is."""
    if route.period is None:
        return (0,)
    cycles = question.scene.cycles
    until_steady = 2 if steady_from is None else steady_from + 1
    _, whole = turns_of(route.marks[0], route.period, cycles, question.time)
    count = whole or min(cycles, until_steady)
    covered = tuple(min(k, 1) for k in range(count))
    if question.wants_last_cycle_alone:
        return covered[-1:]
    return covered


def instants_of(question: Question, rows: PathRows, last_cycle: slice) -> tuple[Array, Indices]:
    """Instants of the answer and their rows, (n,) each."""
    if question.time is None:
        begin = last_cycle.start if question.wants_last_cycle_alone else 0
        numbers = np.arange(begin, last_cycle.stop)
        return rows.time[numbers], numbers
    inside, _ = within(question.time, float(rows.time[0]), float(rows.time[-1]), rows.period)
    after = np.clip(np.searchsorted(rows.time, inside), 1, len(rows.time) - 1)
    is_before = inside - rows.time[after - 1] < rows.time[after] - inside
    return question.time, after - is_before


def series_at(question: Question, bodies: PathSeries, numbers: Indices) -> dict[str, Array]:
    """Loads, half-widths, edges and movements at rows (n,)."""
    unknown = np.full(len(numbers), np.nan)
    displacement = unknown
    approach = unknown
    if question.wants("tangential_displacement"):
        displacement = bodies.tangential_displacement[numbers]
    if question.wants("normal_approach"):
        approach = bodies.normal_approach[numbers]
    half = bodies.half_width[numbers]
    stick = bodies.stick_half_width[numbers]
    sides = np.array([-1.0, 1.0])
    return {
        "normal_load": bodies.followed.normal_load[numbers],
        "tangential_load": bodies.followed.tangential_load[numbers],
        "tangential_displacement": displacement,
        "normal_approach": approach,
        "contact_half_width": half,
        "stick_half_width": stick,
        "contact_edges": half[:, None] * sides,
        "stick_edges": stick[:, None] * sides,
    }


def grids_at(
    question: Question, points: PointFields, distance: Array, numbers: Indices
) -> dict[str, NDArray[Any]]:
    """pressure, shear, slip, state: (n, k); NaN (open) what was not asked for."""
    shape = (len(numbers), len(distance))
    grids: dict[str, NDArray[Any]] = {
        name: np.broadcast_to(np.nan, shape) for name in ("pressure", "shear", "slip")
    }
    grids["state"] = np.broadcast_to(np.int8(OPEN), shape)
    if question.wants("pressure"):
        grids["pressure"] = points.pressure(numbers)
        if np.any(grids["pressure"] < 0):
            raise splits()
    if question.wants("shear"):
        grids["shear"] = points.shear(numbers)
    if question.wants("slip"):
        grids["slip"] = points.slip(numbers)
    if question.wants("state"):
        grids["state"] = _states(points, distance, numbers)
    return grids


def _states(points: PointFields, distance: Array, numbers: Indices) -> NDArray[np.int8]:
    """Open, stick or slip, (n, k): of slip the zone at the edge, and one further in, which may slip
    in the other sense or while the edge rests.
    """
    bodies = points.series
    followed = bodies.followed
    sides = np.array([-1.0, 1.0])
    half = bodies.half_width[numbers, None]
    front = followed.table.half_width(followed.front[numbers])[:, None]
    ring = followed.table.half_width(followed.ring[numbers])
    by_sense = np.array((SLIP_REVERSE, STICK, SLIP_FORWARD), dtype=np.int8)
    at_edge = by_sense[followed.direction[numbers, None] + 1]
    in_ring = by_sense[followed.ring_direction[numbers, None] + 1]
    # Of full slip only the middle is within the front, and it slips.
    is_within_front = between(front * sides, distance) & (front > 0)
    states = np.where(is_within_front, np.int8(STICK), at_edge)
    is_in_ring = (distance > ring[:, [0]]) & (distance < ring[:, [1]])
    states = np.where(is_in_ring, in_ring, states)
    for number, further in points.inner_slips(numbers):
        of_row = np.where(is_within_front[number], np.int8(STICK), at_edge[number])
        states[number] = np.where(further.slips, by_sense[further.sense + 1], of_row)
    is_pressed = followed.normal_load[numbers, None] > 0
    touches = between(half * sides, distance) & is_pressed
    return np.where(touches, states, np.int8(OPEN))


class _Work(NamedTuple):
    """Friction work of the covered cycles (c,), closed integral of the last, its W(x) (k,), NaN
    what is not wanted or known; relative errors by name.
    """

    cycles: Array
    loop: float
    density: Array
    errors: dict[str, float]


def _work_of(paths: _Paths, points: PointFields, distance: Array, odd: OddPart) -> _Work:
    """Exact theory's work plus what the bodies change, by the steps."""
    question = paths.question
    half_planes = paths.half_planes
    last = paths.last_cycle
    cycles = np.full(len(paths.covered), np.nan)
    loop = math.nan
    density = np.full(len(distance), np.nan)
    wanted = question.fields & _OF_WORK
    errors: dict[str, float] = {}
    if not wanted:
        return _Work(cycles, loop, density, errors)
    ends = paths.rows.time[list(paths.rows.ends)]
    of_half_planes = replace(
        question,
        effects=None,
        fields=wanted,
        x=distance,
        time=ends,
        cycles="all",
    )
    theory = by_memory(of_half_planes, None)
    if question.wants("dissipation"):
        of_theory = np.asarray(theory.values["cycle_dissipation"])
        exact = of_theory[np.minimum(paths.covered, len(of_theory) - 1)]
        cycles, loop, errors = _works_of_cycles(paths, exact, odd)
        if "dissipation" in errors:
            errors["dissipation"] += theory.errors.get("dissipation", 0.0)
    if question.wants("dissipation_density"):
        exact_density = np.asarray(theory.values["dissipation_density"])
        by_steps = PointFields(half_planes, distance).work(last)
        with_bodies = points.work(last)
        density = np.maximum(exact_density + with_bodies - by_steps, 0.0)
        density = np.where(with_bodies > 0, density, 0.0)
        largest = float(np.max(exact_density, initial=0.0))
        if largest > 0:
            difference = np.abs(by_steps - exact_density)
            errors["dissipation_density"] = float(np.max(difference)) / largest
            if half_planes.work(last) > 0:
                effects = question.effects
                assert effects is not None  # for the type checker
                left = left_of_work(paths.bodies, half_planes, last, effects)
                errors["dissipation_density"] += left
    return _Work(cycles, loop, density, errors)


def _works_of_cycles(
    paths: _Paths, exact: Array, odd: OddPart
) -> tuple[Array, float, dict[str, float]]:
    """Friction work of the covered cycles (c,), closed integral of the last, relative errors.

    Parameters
    ----------
    exact
        work of these cycles by exact theory of half-planes, (c,)
    """
    half_planes = paths.half_planes
    bodies = paths.bodies
    cycles = [paths.rows.cycles[k] for k in paths.covered]
    by_steps = np.array([half_planes.work(rows) for rows in cycles])
    with_bodies = np.array([bodies.work(rows) for rows in cycles])
    of_odd_numbers = [odd.work(k) for k in paths.covered]
    works = exact + (with_bodies - by_steps)
    works = works + np.array([work.value for work in of_odd_numbers])

    # displacements do not have what tilt and bulk strain do to slip
    has_loop = (
        paths.question.wants("loop_work")
        and odd.answer is None
        and odd.on_grids is None
        and paths.is_steady
        and paths.rows.period is not None
    )
    loop = bodies.loop_work(paths.last_cycle) if has_loop else math.nan
    work = float(exact[-1])
    if work <= 0:
        return works, loop, {}
    of_steps = _OF_STEPS * abs(float(by_steps[-1]) / work - 1)
    of_steps += _OF_HALVED * abs(_work_of_halved_steps(paths) - float(with_bodies[-1])) / work
    of_odd = of_odd_numbers[-1].uncertainty / work
    effects = paths.question.effects
    assert effects is not None  # for the type checker
    of_next_orders = left_of_work(bodies, half_planes, paths.last_cycle, effects)
    errors = {"dissipation": of_steps + of_odd + of_next_orders}
    if odd.left_out:
        errors["dissipation"] = math.nan  # how much tilt and strain add is not known
    if has_loop:
        by_loop = half_planes.loop_work(paths.last_cycle)
        errors["loop_work"] = abs(by_loop / work - 1) + of_next_orders
    return works, loop, errors


def left_of_work(
    bodies: PathSeries, half_planes: PathSeries, rows: slice, effects: BodyEffects
) -> float:
    """What the orders after the next leave in W of a cycle, over that of half-planes: of what each
    curvature changes its own share.
    """
    left = left_of_curvatures(effects, float(np.max(half_planes.half_width[rows])))
    of_half_planes = half_planes.work(rows)
    change = bodies.work(rows) / of_half_planes - 1
    bend = curvatures_of(effects)
    if bend.are_of_mirrored_bodies and bend.normal >= 0 and bend.tangential >= 0:
        # Both change W in one direction.
        return abs(change) * max(left.values()) + LEFT_IN_ANY_CASE
    followed = bodies.followed
    loads = (followed.normal_load, followed.tangential_load)
    uncertainty = LEFT_IN_ANY_CASE
    rest = change
    for words in CURVATURES:
        these_alone = curvatures_of(with_these_alone(effects, words))
        by_rows = (followed.table, followed.friction, *loads)
        by_these = follow(*by_rows, these_alone, half_planes.followed)
        work = bodies.unit * float(np.sum(by_these.step_work[rows][1:]))
        part = work / of_half_planes - 1
        uncertainty += abs(part) * left[words]
        rest -= part
    return uncertainty + abs(rest) * sum(left.values())


def _errors_of_contact(paths: _Paths) -> dict[str, float]:
    """What the orders after the next leave in the largest pressure and half-width, over them."""
    effects = paths.question.effects
    assert effects is not None  # for the type checker
    bodies = paths.bodies
    half_planes = paths.half_planes
    last = paths.last_cycle
    row = np.array([last.start + int(np.argmax(bodies.followed.normal_load[last]))])
    largest_half_width = float(np.max(half_planes.half_width[last]))
    if not largest_half_width > 0:
        return {}
    places = largest_half_width * np.sin(np.linspace(0.0, math.pi / 2, _LOOKED_AT))
    pressures = [
        float(np.max(PointFields(series, places).pressure(row))) for series in (bodies, half_planes)
    ]
    left = max(left_of_curvatures(effects, largest_half_width).values())
    of_pressure = abs(pressures[0] / pressures[1] - 1) if pressures[1] else 0.0
    of_half_width = abs(float(bodies.half_width[row[0]] / half_planes.half_width[row[0]]) - 1)
    return {
        "pressure": of_pressure * left + LEFT_IN_ANY_CASE,
        "contact_half_width": of_half_width * left + LEFT_IN_ANY_CASE,
    }


def _work_of_halved_steps(paths: _Paths) -> float:
    """Friction work of the last cycle by two steps in the place of each long one in which the
    contact grows in stick: that is a chord, and every other step is exact however long it is.
    """
    followed = paths.bodies.followed
    effects = paths.question.effects
    assert effects is not None  # for the type checker
    count = len(followed.normal_load)
    grows_in_stick = (np.diff(followed.edge) > 0) & (followed.direction[1:] == 0)
    growth = np.diff(followed.normal_load) / np.max(followed.normal_load)
    chords = np.flatnonzero(grows_in_stick & (growth > _SHORT_CHORD))
    if not len(chords):
        return paths.bodies.work(paths.last_cycle)
    rows = np.union1d(np.arange(count), chords + 0.5)
    normal_load, tangential_load = (
        np.interp(rows, np.arange(count), load)
        for load in (followed.normal_load, followed.tangential_load)
    )
    loads = (normal_load, tangential_load)
    halved = follow(followed.table, followed.friction, *loads, curvatures_of(effects))
    begin, end, _ = paths.last_cycle.indices(count)
    is_of_cycle = (rows > begin) & (rows <= end - 1)
    return paths.bodies.unit * float(np.sum(halved.step_work[is_of_cycle]))


def _odd_part(paths: _Paths) -> OddPart:
    """What tilt and bulk strain of the effects make."""
    question = paths.question
    effects = question.effects
    assert effects is not None  # for the type checker
    if not any(getattr(effects, name).value for name in ODD_NUMBERS):
        return OddPart()
    try:
        odd = OddPart(odd_answer(question.scene, effects))
    except Declined as reason:
        if not question.wants("dissipation"):
            return OddPart(left_out=str(reason))
        work = paths.bodies.work(paths.last_cycle)
        odd = odd_part_on_grids(question.scene, effects, work, str(reason))
    of_half_planes = paths.half_planes.work(paths.last_cycle)
    if not of_half_planes > 0:
        return odd
    of_curvatures = paths.bodies.work(paths.last_cycle) / of_half_planes - 1
    ratio = ratio_of_next_order(effects, paths.largest_half_width)
    return odd._replace(left=left_of_tilt_and_strain(of_curvatures, ratio))


def odd_part_on_grids(scene: Scene, effects: BodyEffects, work: float, reason: str) -> OddPart:
    """The same on grids, where the second order does not hold for that reason: the change that they
    find of half-planes, of `work` with the curvatures of the bodies.

    Where they take neither, it is left out.
    """
    try:
        of_half_planes = work_of_half_planes(scene)
        if not of_half_planes > 0:
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
    """Largest difference of q and s of half-planes by the steps and by exact theory, 1 % of a away
    from edges, over the largest f p and s.
    """
    question = paths.question
    half_planes = paths.half_planes
    names = tuple(name for name in ("shear", "slip") if question.wants(name))
    friction = half_planes.followed.friction
    if not names or not friction:
        return {}
    last = paths.last_cycle
    numbers = np.unique(np.linspace(last.start, last.stop - 1, _INSTANTS).astype(int))
    x = np.linspace(0.0, float(np.max(half_planes.half_width[numbers])), _PLACES)[1:]
    theory = by_memory(
        replace(
            question,
            effects=None,
            fields=frozenset(names),
            x=x,
            time=paths.rows.time[numbers],
            cycles="all",
        ),
        None,
    )
    points = PointFields(half_planes, x)
    pressure = points.pressure(numbers)
    largest_pressure = float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
    half = half_planes.half_width[numbers, None]
    stick = np.nan_to_num(half_planes.stick_half_width[numbers, None])
    is_away = (np.abs(x - half) > _NEAR * half) & (np.abs(x - stick) > _NEAR * half)
    by_steps = {"shear": points.shear, "slip": points.slip}
    errors = {}
    for name in names:
        exact = theory.values[name]
        difference = np.where(is_away, np.abs(by_steps[name](numbers) - exact), 0.0)
        scale = friction * largest_pressure if name == "shear" else float(np.max(np.abs(exact)))
        if scale > 0:
            errors[name] = float(np.max(difference)) / scale
    return errors


def permanent_stick(bodies: PathSeries, rows: slice, centre: Array | float = 0.0) -> float:
    """Half-width of what sticks all through a cycle; NaN if nothing does.

    Parameters
    ----------
    centre
        of the stick zone at these rows, (n,)
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
    """What a reader must not miss."""
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
    bodies: PathSeries, grids: Mapping[str, NDArray[Any]], numbers: Indices
) -> dict[str, Array]:
    """|M(a) - Q| over f max P, and the largest |q| - f p over f max p where both are known."""
    followed = bodies.followed
    friction = followed.friction
    largest = max(friction * float(np.max(followed.normal_load)), np.finfo(float).tiny)
    force = followed.pieces.force[followed.curve[numbers]]
    edge_parabola = followed.table.parabola(followed.edge[numbers])
    carried = force + followed.tangential_curvature[numbers] * edge_parabola
    edge_fourth = followed.table.fourth(followed.edge[numbers])
    carried = carried + followed.tangential_fourth[numbers] * edge_fourth
    is_pressed = followed.normal_load[numbers] > 0
    balance = np.where(is_pressed, np.abs(carried - followed.tangential_load[numbers]), 0.0)
    checks = {"tangential_balance": balance / largest}
    pressure = grids["pressure"]
    shear = grids["shear"]
    if np.any(np.isfinite(pressure)) and np.any(np.isfinite(shear)):
        with np.errstate(invalid="ignore"):
            excess = np.abs(shear) - friction * pressure
        limit = friction * float(np.max(pressure, where=np.isfinite(pressure), initial=0.0))
        excess_of_instant = np.fmax.reduce(excess, axis=1, initial=0.0)
        checks["cone"] = excess_of_instant / max(limit, np.finfo(float).tiny)
    return checks
