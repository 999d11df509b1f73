"""Rows of a loop whose Q has one highest and one lowest value in a cycle: which of them are of one
steady loop, their fit, and why others are refused.

# notation: f friction coefficient, P and Q loads, U relative displacement

At constant P the form of Q and U over time counts for nothing. Rows before the first turning point
may be of the initial loading: of three cycles and more they are left out. Half cycles are left out
until the parameters of the loop no longer change: neither with time, nor between the first half
cycle and the others (F test, `loop_steadiness.change_of`). Refused are a drift that is none of a
gauge, cycles that grow, shrink or have another period, and loops whose form is not that of theory.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.loop_area import polygon_area
from reports.scoring.loop_branches import Branches, find_branches, row_noise
from reports.scoring.loop_fit import LoopFit, LoopRows, LoopsOverFriction, RowNoise, fit_loop
from reports.scoring.loop_fitted import FittedLoop, sentences_on_scale
from reports.scoring.loop_masing import MasingLoop, MeasuredRows, MemoryCurve, memory_curve
from reports.scoring.loop_masing_fit import BestLoop, MasingFit, best_loop, fit_with_interval
from reports.scoring.loop_rows import MeasuredLoop
from reports.scoring.loop_steadiness import (
    NO_CHANGE,
    ExplainedChange,
    Misfit,
    differences_of_cycles_in_words,
    drift_of_displacement,
    lasting_growth,
)
from reports.scoring.loop_theory import (
    FINE_SHARES_OF_CYCLE,
    N_INSTANTS,
    cycle_loads,
    friction_at_gross_sliding,
    has_constant_normal_load,
    theory_displacement,
)
from reports.units import units
from scenes import InputError, Scene
from scenes.array_types import Array

# Relative error of a fitted f by theory at so many instants, straight between; and by samples of
# the memory curve. A loop that slides has f from its plateaus, but for round-off in f of sliding.
_RELATIVE_ERROR_OF_THEORY = 1e-5
_RELATIVE_ERROR_OF_MEMORY_CURVE = 1e-6
_RELATIVE_ERROR_OF_SLIDING = 2e-9
# Part of the distances that is no scatter, over the mean opening of the loop in U, from which rows
# under a varying P are said not to be examined.
_LARGEST_SHARE_OF_OPENING_WHERE_LOAD_VARIES = 0.02
# The same at constant P, beyond which rows are of no loop of theory; where nearly all of the
# distances is no scatter (a correlation of neighbours above that), a smaller part shows as much.
_LARGEST_SHARE_OF_OPENING = 0.015
_CORRELATION_WITHOUT_SCATTER = 0.8
_LARGEST_SHARE_OF_OPENING_WITHOUT_SCATTER = 0.005
# Part of the distances that is no scatter, in sigma of U, below which it is that of nearest points:
# 4 % of sigma were measured where sigma is half of the opening.
_SIGMAS_OF_NEAREST_POINTS = 0.1
# Systematic part of the distances, over the loop's opening, from which it is stated: theory's own
# error of a loop is below it.
_LEAST_SHARE_STATED = 1e-3
# A U that changes by more than this share of its range from cycle to cycle is no drift of a gauge.
_LARGEST_DRIFT = 0.03
# A drift below this share of the range of U over the record is not stated.
_LEAST_DRIFT_STATED = 1e-3
# Cycles from which on rows before the first turning point are left out.
_FEWEST_CYCLES_WITH_RUN_IN = 3.0
# Cycles that are left without a run-in, at least: fewer do not show whether they are alike.
_FEWEST_CYCLES = 2.4
# Numbers of half-cycles behind the first turning point that are left out, in the order of trial.
_HALF_CYCLES_OF_RUN_IN = (0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 16)
# Chance of scatter alone below which a half cycle more is left out: it costs little; and below
# which the loop is said to change.
_LARGEST_CHANCE_TO_LEAVE_OUT = 0.02
_LARGEST_CHANCE_OF_CHANGE = 1e-3
# Chance below which the interval of f holds a change; behind a run-in it always does.
_LARGEST_CHANCE_TO_WIDEN = 0.05
# Rise of Q along the slide of a gross loop, over its range, from which it is no plateau.
_LEAST_RISE_WITHOUT_PLATEAU = 0.02
# A first row so near to a turning point [half-cycles] lies on it; a first half-cycle that is so
# short [cycles] is taken together with the next one.
_LARGEST_DISTANCE_ON_TURN = 0.02
_SHORTEST_FIRST_HALF_CYCLE = 0.1


def fit_steady_rows(
    measured_loop: MeasuredLoop, scene: Scene, rig_compliance: float | None
) -> tuple[MeasuredLoop, FittedLoop]:
    """Choose the rows of a measured loop of Q over U that repeat one steady cycle, and fit the
    friction coefficient f to them.

    Where P varies all rows are fitted. Where it is constant first half-cycles are left out until
    the remaining rows are steady, and a linear drift of U is taken out.

    Parameters
    ----------
    measured_loop
        U, Q and time of the rows, and their file `source`
    rig_compliance
        compliance C of the rig between the places where U is measured [1/stress]; None fits it

    Returns
    -------
    rows, fit
        the rows that were fitted, and their fit

    Raises
    ------
    InputError
        For rows of less than a cycle, or in which Q does not go up and down. At constant P also
        where cycles differ, grow or drift, and where no loop of half-plane theory fits the rows and
        the rig is fitted too.

    # notation: P normal load, Q tangential load, U relative tangential displacement
    """
    if not has_constant_normal_load(scene):
        # Distances from the nearest point of a loop are no scatter beside its turning points: three
        # of twenty good loops with noise were refused by them.
        fit = _fit_where_load_varies(measured_loop, scene, rig_compliance)
        # part of the rows' distances that is no scatter, over the mean opening of the loop in U
        # (its area over the range of Q)
        share_of_opening = _share_of_opening(measured_loop, fit.misfit, fit.cycles_passed)
        if (
            # more than 2 % of the opening
            share_of_opening > _LARGEST_SHARE_OF_OPENING_WHERE_LOAD_VARIES
            or _differences_of_cycles_in_words(measured_loop)
        ):
            fit = _fit_with_sentence(
                fit, "P varies: the rows were not examined for drift, run-in and cycles that differ"
            )
        return measured_loop, _fit_with_sentence_on_widening(fit, share_of_opening)

    # drift of U in a cycle, over the range of U; 0 where it is small enough for a gauge
    drift = _drift_of_cycle(measured_loop)
    if drift:
        raise InputError(
            f"{measured_loop.source}: its rows are of no steady loop: U moves on by"
            f" {100 * drift:+.2g} % of its range in each cycle, so the contact slides on or the"
            " gauge does; give the rows of cycles that are alike"
        )
    _, load_of_cycle = cycle_loads(scene)  # Q
    range_of_load = float(np.ptp(load_of_cycle))
    # of theory: U over half the change of Q since a turning point, from which loops are built
    curve = memory_curve(scene, friction_at_gross_sliding(scene) / range_of_load)
    # the rows without a run-in, their best loop, and tests of their steadiness
    candidate = _steadiest_rows(measured_loop, curve, rig_compliance)
    if rig_compliance is None:
        _require_loop_of_theory(candidate, measured_loop, scene)
    chosen_rows, fit = _fit_at_constant_load(candidate, scene, curve)
    # number of cycles that all measured rows cover
    fit = replace(fit, n_cycles=_branches_by_height(measured_loop).n_cycles)
    # 1.5 % of the opening; only with a stated rig compliance, since else such rows were refused
    if candidate.share_of_opening > _LARGEST_SHARE_OF_OPENING:
        fit = _fit_with_sentence(
            fit,
            "With the stated rig compliance the best fit is"
            f" {100 * candidate.share_of_opening:.2g} % of the loop's opening away from rows that"
            " lie beside each other: leave it out, and it is fitted",
        )
    # wider where f still changes over the rows
    fit = _fit_with_interval_for_change(fit, candidate)
    return chosen_rows, _fit_with_sentence_on_widening(fit, candidate.share_of_opening)


def _fit_with_sentence(fit: FittedLoop, sentence: str) -> FittedLoop:
    """The fit with a further sentence on what was assumed or left out."""
    return replace(fit, sentences=(*fit.sentences, sentence))


def _steadiest_rows(
    measured_loop: MeasuredLoop, curve: MemoryCurve, rig_compliance: float | None
) -> _Candidate:
    """The rows of a measured loop of Q over U that repeat one cycle, with the loop of theory that
    fits them and tests of their steadiness.

    More and more half-cycles are left out at the begin until the remaining rows are steady. Where
    they never are, the trial that comes nearest to it is taken.

    Parameters
    ----------
    curve
        memory curve of half-plane theory: U over half the change of Q since a turning point, from
        which every branch of the loop follows
    rig_compliance
        compliance C of the rig between the places where U is measured [1/stress]; None fits it

    Raises
    ------
    InputError
        Where the cycles differ or go on growing however many are left out.

    # notation: Q tangential load, U relative tangential displacement
    """
    candidates = []
    growth_words = ""
    difference_words = _differences_of_cycles_in_words(measured_loop)
    for remaining_rows in _rows_without_run_in(measured_loop):
        # "grow" or "shrink" where the remaining cycles may do so as all cycles do; else ""
        growth_of_remaining = remaining_rows.lasting_growth
        if growth_of_remaining:
            growth_words = growth_of_remaining
            continue
        difference_of_remaining = _differences_of_cycles_in_words(remaining_rows.rows)
        if difference_of_remaining:
            difference_words = difference_words or difference_of_remaining
            continue
        candidate = _tested_candidate(remaining_rows, curve, rig_compliance)
        candidates.append(candidate)
        if candidate.is_steady:
            break
    # cycles grow or differ in every trial, or they grow in one and no trial was steady
    if not candidates or (growth_words and not candidates[-1].is_steady):
        reason = difference_words
        if growth_words not in reason:
            reason = (
                f"its cycles {growth_words}, and its noise is too large to tell whether the last"
                " ones still do"
            )
        raise InputError(
            f"{measured_loop.source}: its rows are of no steady loop: {reason}; give the rows of"
            " cycles that are alike"
        )
    if candidates[-1].is_steady:
        return candidates[-1]
    # part of the distances that is no scatter or that a change with time explains, over the opening
    return min(candidates, key=lambda candidate: candidate.unsteady_share_of_opening)


# ------------------------------------------------------------------ rows that may be a steady loop
@dataclass(frozen=True)
class _ChangesOfLoop:
    """How a loop of tangential load Q over displacement U changes over its rows, as tests show it.
    By default it does not.

    Attributes
    ----------
    with_time
        change per cycle of f, of Q's middle and range, and of the rig's compliance
    of_first_half_cycle
        difference between the first half-cycle and the others
    every_second_cycle
        difference between every second cycle and the others
    of_size
        growth of U and Q per cycle, over themselves
    of_log_friction
        by how much ln f of the last row differs from the fitted one, for the change of size
    """

    with_time: ExplainedChange = NO_CHANGE
    of_first_half_cycle: ExplainedChange = NO_CHANGE
    every_second_cycle: ExplainedChange = NO_CHANGE
    of_size: ExplainedChange = NO_CHANGE
    of_log_friction: float = 0.0


@dataclass(frozen=True, eq=False)
class _Candidate:
    """Rows without a run-in, the loop that fits them, and tests of whether they are steady.

    Attributes
    ----------
    share_of_opening
        part of the distances from the loop that is no scatter, over the loop's mean opening in U
    rows
        the measured rows that are left
    branches
        turning points and the branch of each row
    best_loop
        the fitted loop
    run_in_sentence
        which rows were left out, in words; "" where none were
    had_run_in
        whether more than the rows before the first turning point were left out
    changes
        how the loop changes over the rows, and with which chance by scatter alone
    sigma_over_opening
        standard deviation of the noise of U, over the loop's mean opening in U
    """

    share_of_opening: float
    rows: MeasuredLoop
    branches: Branches
    best_loop: BestLoop
    run_in_sentence: str
    had_run_in: bool
    changes: _ChangesOfLoop
    sigma_over_opening: float

    @property
    def is_steady(self) -> bool:
        """Whether no test shows that the loop changes: neither with time, nor in size, nor between
        the first half-cycle and the later ones. Scatter alone must explain each with a chance of
        more than 2 %.
        """
        chances = (
            self.changes.with_time.chance,
            self.changes.of_first_half_cycle.chance,
            self.changes.of_size.chance,
        )
        return min(chances) > _LARGEST_CHANCE_TO_LEAVE_OUT

    @property
    def unsteady_share_of_opening(self) -> float:
        """Part of the distances of the rows from the loop that is no scatter, or that a change with
        time explains; the larger of both, over the loop's mean opening in U.
        """
        # explained_rms: in sigma of the noise of U
        share_by_change = self.changes.with_time.explained_rms * self.sigma_over_opening
        return max(self.share_of_opening, share_by_change)

    @property
    def rise_along_slide(self) -> float:
        """By how much Q rises while the contact slides as a whole, over the range of Q; 0 where it
        has a plateau, where the contact never slides so, or where scatter gives as much.
        """
        if not self.best_loop.is_gross:
            return 0.0
        # change: its `chance` is that with which scatter alone explains the rise
        rise, change = self.best_loop.rise_along_slide()
        is_not_by_chance = change.chance < _LARGEST_CHANCE_OF_CHANGE
        return rise if is_not_by_chance and rise > _LEAST_RISE_WITHOUT_PLATEAU else 0.0

    def is_certain(self, change: ExplainedChange) -> bool:
        """Whether a change of the loop is not by chance (below 0.1 %), and more than theory may
        miss: 1.5 % of the mean opening of the loop in U.
        """
        # explained_rms: distances that the change explains, in sigma of the noise of U
        share_of_opening = change.explained_rms * self.sigma_over_opening
        return (
            change.chance < _LARGEST_CHANCE_OF_CHANGE
            and share_of_opening > _LARGEST_SHARE_OF_OPENING
        )


def _tested_candidate(
    remaining_rows: _RowsWithoutRunIn, curve: MemoryCurve, rig_compliance: float | None
) -> _Candidate:
    """Fit the loop of theory to the rows that are left without a run-in, and test whether these are
    steady: whether f, U or Q change with time, whether the first half-cycle differs, and whether
    every second cycle does. Returns the rows, the best loop, and these tests.

    Parameters
    ----------
    remaining_rows
        the rows that are left, and which were left out
    curve
        memory curve of theory: U over half the change of Q since a turning point, from which loops
        are built
    rig_compliance
        compliance C of the rig [1/stress]; None fits it

    # notation: f coefficient of friction, Q tangential load, sigma standard deviation of the noise
    #           of U, U relative tangential displacement
    """
    measured_rows = remaining_rows.rows
    # branch of each row, and the number of cycles passed at it
    branches = _branches_by_height(measured_rows)
    rows_to_fit = MeasuredRows(
        displacement=measured_rows.displacement,
        load=measured_rows.load,
        time=measured_rows.time,
        branches=branches,
        compliance=rig_compliance,
        resolution=measured_rows.resolution,
    )
    fitted_loop = best_loop(rows_to_fit, curve)
    # part of the rows' distances that is no scatter, over the mean opening of the loop in U
    # (its area over the range of Q)
    share_of_opening = _share_of_opening(measured_rows, fitted_loop.misfit, branches.cycles_passed)
    sigma_over_opening = fitted_loop.search.sigma.of_displacement / _mean_opening(
        measured_rows, branches.cycles_passed
    )
    # noise alone moves the nearest points of the loop by as much: a tenth of sigma
    if share_of_opening < _SIGMAS_OF_NEAREST_POINTS * sigma_over_opening:
        share_of_opening = 0.0
    return _Candidate(
        share_of_opening=share_of_opening,
        rows=measured_rows,
        branches=branches,
        best_loop=fitted_loop,
        run_in_sentence=remaining_rows.sentence,
        had_run_in=remaining_rows.n_half_cycles > 0,
        changes=_changes_of_loop(fitted_loop, branches),
        sigma_over_opening=sigma_over_opening,
    )


def _changes_of_loop(fitted_loop: BestLoop, branches: Branches) -> _ChangesOfLoop:
    """How a fitted loop of tangential load Q over displacement U changes over its rows: with time,
    between its first half-cycle and the others, between every second cycle and the others, and in
    size. With each comes the chance of scatter alone to show as much. No change is taken for rows
    of fewer than 2.4 cycles.

    `branches.cycles_passed` (n,) are the cycles that have passed at each row. A first half-cycle of
    less than a tenth of a cycle is taken together with the next one.
    """
    if branches.n_cycles < _FEWEST_CYCLES:
        return _ChangesOfLoop()
    ascending_cycles_passed = np.maximum.accumulate(branches.cycles_passed)  # (n,), noise taken out
    # first turning point behind the first row
    cycles_at_turn = _cycles_at_first_turn(ascending_cycles_passed)
    if cycles_at_turn - ascending_cycles_passed[0] < _SHORTEST_FIRST_HALF_CYCLE:
        cycles_at_turn += 0.5
    is_in_first_half_cycle = ascending_cycles_passed < cycles_at_turn
    # waves with a period of two cycles
    alternating_changes = [
        fitted_loop.change_with(wave(np.pi * ascending_cycles_passed)) for wave in (np.cos, np.sin)
    ]
    change_of_size = fitted_loop.change_of_size_with(ascending_cycles_passed)
    return _ChangesOfLoop(
        with_time=fitted_loop.change_with(ascending_cycles_passed),
        of_first_half_cycle=fitted_loop.change_with(is_in_first_half_cycle.astype(float)),
        every_second_cycle=min(alternating_changes, key=lambda change: change.chance),
        of_size=change_of_size,
        # of ln f, if all rows were as large as the last ones; added_values: growth of U and of Q
        of_log_friction=fitted_loop.log_friction_change(
            change_of_size.added_values, ascending_cycles_passed
        ),
    )


def _require_loop_of_theory(
    candidate: _Candidate, measured_loop: MeasuredLoop, scene: Scene
) -> None:
    """Raise InputError, with the reason, where theory has no such steady loop: where cycles change,
    where Q rises while the contact slides, or where even the best fit lies far beside the rows. How
    far is stated over the mean opening of the loop in U, its area over the range of Q.

    Parameters
    ----------
    candidate
        the rows that were chosen, their best loop, and the changes of the loop that were tested:
        every second cycle, with time, in size. `share_of_opening` is the part of the distances of
        the rows that is no scatter; `unsteady_share_of_opening` includes what a change explains
    measured_loop
        all measured rows

    # notation: Q tangential load, U relative tangential displacement
    """
    misfit = candidate.best_loop.misfit
    # 1.5 % of the opening; 0.5 % where neighbouring rows have a correlation of more than 0.8, so
    # that hardly any of the distances is scatter, unless the digits of Q make it
    largest_share_of_opening = _LARGEST_SHARE_OF_OPENING
    if (
        misfit.correlation > _CORRELATION_WITHOUT_SCATTER
        and not candidate.best_loop.depends_on_last_digits
    ):
        largest_share_of_opening = _LARGEST_SHARE_OF_OPENING_WITHOUT_SCATTER
    reason = ""
    # certain: not by chance, and more than theory may miss
    if candidate.is_certain(candidate.changes.every_second_cycle):
        reason = "its period is another: every second cycle is alike"
    elif candidate.is_certain(candidate.changes.with_time) or candidate.is_certain(
        candidate.changes.of_size
    ):
        # of U and of Q in per cent, over all cycles
        growth = 100 * candidate.changes.of_size.added_values * candidate.branches.n_cycles
        reason = (
            f"its cycles change to the end: U grows by {growth[0]:+.2g} % and Q by"
            f" {growth[1]:+.2g} % over {candidate.branches.n_cycles:.2g} cycles"
        )
    elif candidate.rise_along_slide:
        reason = (
            f"its Q rises by {100 * candidate.rise_along_slide:.2g} % of its range while the"
            " contact slides as a whole: it hardens (plastic flow, debris, or a pad that tilts),"
            " and has no plateau at f P"
        )
    elif candidate.share_of_opening > largest_share_of_opening:
        reason = (
            "its cycles are alike, but their form is not that of theory (other bodies, plastic"
            " flow, wear, or noise that is no scatter)"
        )
    if not reason:
        return
    raise InputError(
        f"{measured_loop.source}: its rows are of no steady loop of {scene.name}:"
        f" {_differences_of_cycles_in_words(measured_loop) or reason}; the best fit is"
        f" {100 * candidate.unsteady_share_of_opening:.2g} % of the loop's opening away from rows"
        f" that lie beside each other (limit {100 * largest_share_of_opening:.2g} %)"
    )


def _fit_with_interval_for_change(fit: FittedLoop, candidate: _Candidate) -> FittedLoop:
    """Widen the 95 % interval of f of a fitted measured loop by how much f still changes up to the
    last row. The fit stays as it is where the loop does not change in size and no run-in was left
    out. The ends are `lowest_friction` and `highest_friction`, None without an upper end.

    `candidate` holds the tests of the rows' steadiness: `changes.of_size.chance` with which scatter
    alone shows such a growth of U and Q, and the change of ln f that goes with it.

    # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
    """
    # scatter alone shows such a growth with a chance of more than 5 %
    if candidate.changes.of_size.chance > _LARGEST_CHANCE_TO_WIDEN and not candidate.had_run_in:
        return fit
    # change of ln f: a change by more than a factor e counts as one by e
    log_change = candidate.changes.of_log_friction
    # fit.friction: f that fits best
    friction_change = fit.friction * math.expm1(min(abs(log_change), 1.0))
    distance_to_lower_end = math.hypot(fit.friction - fit.lowest_friction, friction_change)
    highest_friction = None
    if fit.highest_friction is not None:
        distance_to_upper_end = math.hypot(fit.highest_friction - fit.friction, friction_change)
        highest_friction = fit.friction + distance_to_upper_end
    sentence = (
        "The loop still changes over the rows that are left, f by"
        f" {100 * math.expm1(min(log_change, 1.0)):+.2g} % to the last one: the interval"
        " of f holds it"
    )
    return replace(
        _fit_with_sentence(fit, sentence),
        lowest_friction=max(fit.friction - distance_to_lower_end, 0.0),
        highest_friction=highest_friction,
    )


@dataclass(frozen=True, eq=False)
class _RowsWithoutRunIn:
    """Rows that may be of one steady loop: those from the index `first_row` of `all_rows` on. The
    rows before it hold `n_half_cycles` half-cycles behind the first turning point; `sentence`
    states which were left out.
    """

    all_rows: MeasuredLoop
    first_row: int
    n_half_cycles: int
    sentence: str

    @property
    def rows(self) -> MeasuredLoop:
        """The rows that are left."""
        loop = self.all_rows
        return replace(
            loop,
            displacement=loop.displacement[self.first_row :],
            load=loop.load[self.first_row :],
            time=loop.time[self.first_row :],
        )

    @property
    def lasting_growth(self) -> str:
        """The word "grow" or "shrink" where the remaining cycles of a measured loop may still do so
        at the rate of all cycles: then the rows that were left out are no run-in. Else "".
        """
        if not self.n_half_cycles:
            return ""
        loop = self.all_rows
        # by the trend of the size of U and Q over all rows, and over the later ones
        return lasting_growth(
            loop.displacement, loop.load, loop.time, self.first_row, _noise_of_load(loop)
        )


def _rows_without_run_in(measured_loop: MeasuredLoop) -> Iterator[_RowsWithoutRunIn]:
    """The rows of a measured loop without a run-in. More and more first half-cycles are left out,
    each time with a sentence that states it. Where the loop has fewer than three cycles, all rows
    come first. In all other cases at least 2.4 cycles are left.
    """
    cycles_passed = np.maximum.accumulate(_branches_by_height(measured_loop).cycles_passed)
    if cycles_passed[-1] - cycles_passed[0] < _FEWEST_CYCLES_WITH_RUN_IN:
        # the rows from `first_row` on, and a sentence on those left out
        yield _RowsWithoutRunIn(measured_loop, first_row=0, n_half_cycles=0, sentence="")
    # at the first turning point behind the first row
    cycles_at_turn = _cycles_at_first_turn(cycles_passed)
    # numbers of half-cycles from 0 to 16
    for n_half_cycles in _HALF_CYCLES_OF_RUN_IN:
        first_row = int(np.argmax(cycles_passed >= cycles_at_turn + n_half_cycles / 2))
        if cycles_passed[-1] - cycles_passed[first_row] < _FEWEST_CYCLES or not first_row:
            return
        sentence = f"Rows 1 to {first_row} are left out: run-in, unlike the later cycles"
        if not n_half_cycles:
            sentence = (
                f"Rows 1 to {first_row}, before the first turning point, are left out: they may be"
                " of the initial loading"
            )
        yield _RowsWithoutRunIn(measured_loop, first_row, n_half_cycles, sentence)


def _cycles_at_first_turn(cycles_passed: Array) -> float:
    """Number of cycles passed at the first turning point behind the first row: a multiple of 1/2,
    as at every turning point. `cycles_passed` (n,) are those at the rows.
    """
    return math.ceil(2 * cycles_passed[0] + _LARGEST_DISTANCE_ON_TURN) / 2


def _branches_by_height(measured_loop: MeasuredLoop) -> Branches:
    """Branches of the rows of a measured loop, rising or falling, by the height U/(range of U) +
    Q/(range of Q). It has its turning points where the branches have theirs, also where Q stays
    while the contact slides.
    """
    range_of_displacement = float(np.ptp(measured_loop.displacement))
    range_of_load = float(np.ptp(measured_loop.load))
    height = measured_loop.displacement / range_of_displacement + measured_loop.load / range_of_load
    # steps that the digits of U and of Q resolve
    step_of_displacement, step_of_load = measured_loop.resolution
    step_of_height = step_of_displacement / range_of_displacement + step_of_load / range_of_load
    return find_branches(
        measured_loop.displacement, height, measured_loop.time, step_of_height, measured_loop.source
    )


def _share_of_opening(measured_loop: MeasuredLoop, misfit: Misfit, cycles_passed: Array) -> float:
    """The part of the rows' distances from a fit that is no scatter, over the mean opening of the
    loop in U.
    """
    return misfit.systematic_rms / _mean_opening(measured_loop, cycles_passed)


def _mean_opening(measured_loop: MeasuredLoop, cycles_passed: Array) -> float:
    """Mean opening of the loop in U [length]: its area over the range of Q. `cycles_passed` (n,)
    are the cycles that have passed at each row.
    """
    area = polygon_area(
        measured_loop.displacement, measured_loop.load, cycles_passed, 0.0, 0.0
    ).value
    return max(abs(area), 1e-300) / float(np.ptp(measured_loop.load))


def _differences_of_cycles_in_words(measured_loop: MeasuredLoop) -> str:
    """How the cycles of a measured loop differ, in words; "" where they do not."""
    return differences_of_cycles_in_words(
        measured_loop.displacement,
        measured_loop.load,
        measured_loop.time,
        _noise_of_load(measured_loop),
    )


def _noise_of_load(measured_loop: MeasuredLoop) -> float:
    """Standard deviation of the noise of Q: that of neighbouring rows, at least that of its
    digits.
    """
    return max(row_noise(measured_loop.load), measured_loop.resolution[1] / math.sqrt(12))


def _fit_with_sentence_on_widening(fit: FittedLoop, share_of_opening: float) -> FittedLoop:
    """Add a sentence to the fit of a measured loop: how much wider its interval of f is, since
    neighbouring rows lie on the same side of the loop. `share_of_opening` is how far, over the mean
    opening of the loop in U, its area over the range of Q; below 0.1 % nothing is stated.

    `fit.misfit` holds the correlation of neighbouring rows and the factor `widening`.

    # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
    """
    if fit.misfit.widening == 1.0 or share_of_opening < _LEAST_SHARE_STATED:
        return fit
    return _fit_with_sentence(
        fit,
        "Neighbouring rows lie on the same side of the best fit (correlation"
        f" {fit.misfit.correlation:.2g}), by {100 * share_of_opening:.2g} % of the loop's opening:"
        f" the interval of f is {fit.misfit.widening:.2g} times as wide for it",
    )


def _drift_of_cycle(measured_loop: MeasuredLoop) -> float:
    """Drift of U of a measured loop in a cycle, over the range of U. It is 0 unless it is too large
    for the drift of a gauge: more than 3 %, plus what noise gives.

    # notation: Q tangential load, U relative tangential displacement
    """
    # branch of each row by Q, and cycles that have passed
    _, step_of_load = measured_loop.resolution  # steps that the digits of U and of Q resolve
    branches = find_branches(
        measured_loop.displacement,
        measured_loop.load,
        measured_loop.time,
        step_of_load,
        measured_loop.source,
    )
    # length per unit of time, None where too few rows have another a cycle later
    drift_rate = drift_of_displacement(
        measured_loop.displacement, measured_loop.load, measured_loop.time, branches
    )
    if drift_rate is None:
        return 0.0
    range_of_displacement = float(np.ptp(measured_loop.displacement))
    drift = (
        drift_rate * float(np.ptp(measured_loop.time)) / branches.n_cycles / range_of_displacement
    )
    drift_by_noise = 2 * row_noise(measured_loop.displacement) / range_of_displacement
    return drift if abs(drift) > _LARGEST_DRIFT + drift_by_noise else 0.0


# -------------------------------------------------------------------------------------- their fits
def _fit_at_constant_load(
    candidate: _Candidate, scene: Scene, curve: MemoryCurve
) -> tuple[MeasuredLoop, FittedLoop]:
    """Fit the coefficient of friction f to the measured loop of a scene whose normal load P is
    constant. Returns the loop with the linear drift of U (relative tangential displacement) taken
    out, and the fit with the 95 % interval of f.

    Parameters
    ----------
    candidate
        the rows that were chosen, in cycles that repeat; the loop that fits them best; `branches`,
        with the cycles passed at each row (`cycles_passed`); and which rows were left out, in words
        (`run_in_sentence`, "" for none)
    scene
        gives the tangential load Q over the cycle, to which the measured one is scaled
    curve
        memory curve of half-plane theory: U over half the change of Q since a turning point, from
        which every branch of the loop follows
    """
    # error of a fitted f, over f, by theory: 1e-6, and 2e-9 where the contact slides as a whole
    error_of_theory = _RELATIVE_ERROR_OF_MEMORY_CURVE
    if candidate.best_loop.is_gross:
        error_of_theory = _RELATIVE_ERROR_OF_SLIDING
    # parameters of the loop with their errors, and the interval of f
    masing_fit = fit_with_interval(candidate.best_loop, error_of_theory)
    # Q of the scene through a cycle; factor of the file's Q over it
    _, load_of_cycle = cycle_loads(scene)
    load_scale = (masing_fit.highest_load - masing_fit.lowest_load) / float(np.ptp(load_of_cycle))
    sentences = [
        *_sentences_on_rows(candidate, masing_fit),
        *sentences_on_scale(load_scale),
        *_sentences_on_run_in_and_drift(candidate, masing_fit),
    ]
    if masing_fit.is_gross:
        sentences.append(_sentence_on_slide(masing_fit, scene))
    # Q of the file is `load_scale` times that of the scene, plus `offset`; `misfit`: how the
    # distances of neighbouring rows from the loop go together
    return _rows_without_drift(candidate.rows, masing_fit.drift), FittedLoop(
        scene=scene,
        friction=masing_fit.friction,
        lowest_friction=masing_fit.lowest_friction,
        highest_friction=masing_fit.highest_friction,
        compliance=masing_fit.compliance,
        share_of_cycle=_share_by_place(candidate.rows.load, masing_fit, load_of_cycle),
        cycles_passed=candidate.branches.cycles_passed,
        n_cycles=candidate.branches.n_cycles,
        load_scale=load_scale,
        offset=masing_fit.lowest_load - load_scale * float(load_of_cycle.min()),
        displacement_noise=masing_fit.sigma.of_displacement,
        load_noise=masing_fit.sigma.of_load,
        sentences=tuple(sentences),
        misfit=masing_fit.misfit,
        masing_loop=MasingLoop(curve, masing_fit.parameters),
        masing_fit=masing_fit,
        is_gross=masing_fit.is_gross,
    )


def _rows_without_drift(measured_loop: MeasuredLoop, drift: float) -> MeasuredLoop:
    """The rows of a measured loop with the linear drift of U taken out, so that U in the middle of
    the record's time stays as it is. `drift` is the change of U over the whole record [length].

    # notation: U relative tangential displacement
    """
    share_of_time = (measured_loop.time - measured_loop.time[0]) / float(np.ptp(measured_loop.time))
    return replace(
        measured_loop, displacement=measured_loop.displacement - drift * (share_of_time - 0.5)
    )


def _sentences_on_rows(candidate: _Candidate, fit: MasingFit) -> list[str]:
    """A sentence for the reader of a fit at constant normal load P: how many cycles the rows cover,
    and between which values of the tangential load Q. It states "that are left" where rows of a
    run-in were left out.
    """
    which_rows = " that are left" if candidate.run_in_sentence else ""
    return [
        f"The rows{which_rows} cover {candidate.branches.n_cycles:.4g} cycles between"
        f" Q = {fit.lowest_load:.6g} and {fit.highest_load:.6g}; P is constant, so that the form of"
        " Q and U over time counts for nothing"
    ]


def _sentences_on_run_in_and_drift(candidate: _Candidate, fit: MasingFit) -> list[str]:
    """Sentences for the reader of a fitted loop: which rows were left out as a run-in, and by how
    much U drifts in a cycle. There is none on the drift where it is within its uncertainty, or
    below 0.1 % of the range of U over the record.

    `fit.drift` and `fit.drift_error` are the drift over the record and its standard error [length].

    # notation: U relative tangential displacement
    """
    sentences = [candidate.run_in_sentence] if candidate.run_in_sentence else []
    range_of_displacement = float(np.ptp(candidate.rows.displacement))
    drift_uncertainty = 1.96 * fit.drift_error
    if abs(fit.drift) > max(drift_uncertainty, _LEAST_DRIFT_STATED * range_of_displacement):
        drift_of_cycle = fit.drift / range_of_displacement / candidate.branches.n_cycles
        sentences.append(
            f"U drifts by {100 * drift_of_cycle:+.2g} % of its range in a cycle: taken out"
        )
    return sentences


def _sentence_on_slide(fit: MasingFit, scene: Scene) -> str:
    """A sentence for the reader of a fitted loop whose contact slides as a whole at its ends: how
    far it slides there, and that f is Q/P of this plateau. Q is counted from the middle of the
    loop.

    # notation: f coefficient of friction, P normal load, Q tangential load
    """
    half_range = (fit.highest_load - fit.lowest_load) / 2
    _, unit_of_length, _ = units(scene)
    return (
        f"The contact slides as a whole by {fit.slide:.3g} {unit_of_length} at each end of the"
        f" loop: f is Q/P there, with Q = {half_range:.6g} from the middle"
    )


def _share_by_place(row_loads: Array, fit: MasingFit, load_of_cycle: Array) -> Array:
    """Share of the scene's cycle that is over at each row of a fitted loop, (n,). Where the contact
    slides as a whole it follows from the row's place along the loop; else from the row's tangential
    load Q, on the branch that the place states.

    Parameters
    ----------
    row_loads
        (n,) Q of the rows
    fit
        the fitted loop; `distances.place_on_loop` (n,) is 0 to 1 on the rising branch, and 1 to 2
        on the falling one
    load_of_cycle
        (n_instants,) Q of the scene through a cycle
    """
    place_on_loop = fit.distances.place_on_loop
    if fit.is_gross:
        # a computed loop that slides begins at the highest Q
        return np.asarray(np.mod(place_on_loop / 2 + 0.5, 1.0))
    return _share_by_load(row_loads, place_on_loop < 1, fit, load_of_cycle)


def _fit_where_load_varies(
    measured_loop: MeasuredLoop, scene: Scene, rig_compliance: float | None
) -> FittedLoop:
    """Fit the coefficient of friction f to a measured loop whose scene has a varying normal load P
    and two branches of Q in a cycle: theory's loop between the turning points of Q is fitted to
    the rows. `rig_compliance` is the compliance C of the rig [1/stress]; None fits it too.

    # notation: Q tangential load, U relative tangential displacement
    """
    # branch of each row, and the turning points of Q
    _, step_of_load = measured_loop.resolution  # steps that the digits of U and of Q resolve
    branches = find_branches(
        measured_loop.displacement,
        measured_loop.load,
        measured_loop.time,
        step_of_load,
        measured_loop.source,
    )
    rows = LoopRows(measured_loop.displacement, measured_loop.load, branches, rig_compliance)
    loops_of_theory = _loops_of_theory(scene)
    # error of theory: 1e-5 of f
    loop_fit = fit_loop(rows, loops_of_theory, measured_loop.resolution, _RELATIVE_ERROR_OF_THEORY)
    # Q of the scene through a cycle; factor of the file's Q over it
    _, load_of_cycle = cycle_loads(scene)
    load_scale = (loop_fit.highest_load - loop_fit.lowest_load) / float(np.ptp(load_of_cycle))
    sentences = [
        (
            f"The rows cover {branches.n_cycles:.4g} cycles between Q ="
            f" {loop_fit.lowest_load:.6g} and {loop_fit.highest_load:.6g}; P was taken over Q as in"
            " the scene, so that the form of Q and U over time counts for nothing"
        ),
        *sentences_on_scale(load_scale),
    ]
    # Q of the file is `load_scale` times that of the scene, plus `offset`; `misfit`: how the
    # distances of neighbouring rows from the loop go together
    return FittedLoop(
        scene=scene,
        friction=loop_fit.friction,
        lowest_friction=loop_fit.lowest_friction,
        highest_friction=loop_fit.highest_friction,
        compliance=loop_fit.compliance,
        share_of_cycle=_share_by_nearest_point(rows, loops_of_theory, loop_fit),
        cycles_passed=branches.cycles_passed,
        n_cycles=branches.n_cycles,
        load_scale=load_scale,
        offset=loop_fit.lowest_load - load_scale * float(load_of_cycle.min()),
        displacement_noise=loop_fit.displacement_noise,
        load_noise=loop_fit.load_noise,
        sentences=tuple(sentences),
        misfit=loop_fit.misfit,
    )


def _loops_of_theory(scene: Scene) -> LoopsOverFriction:
    """Half-plane theory's loops of a scene for any friction coefficient f: its tangential load Q
    and its relative tangential displacement U through the steady cycle, at fine instants
    (`FINE_SHARES_OF_CYCLE`).
    """
    return LoopsOverFriction(
        cycle_loads(scene, FINE_SHARES_OF_CYCLE)[1],
        friction_at_gross_sliding(scene),
        lambda friction: theory_displacement(scene, friction, FINE_SHARES_OF_CYCLE),
    )


def _share_by_nearest_point(
    rows: LoopRows, loops_of_theory: LoopsOverFriction, fit: LoopFit
) -> Array:
    """Share of the scene's cycle that is over at each row, (n,): that at the point of theory's loop
    which is nearest to the row.

    Parameters
    ----------
    rows
        U and Q of the n rows, and the branch of each
    loops_of_theory
        U and Q of the scene at instants of the cycle, for any f
    fit
        f that fits best, with turning points of Q, rig and noise (sigma) of U and Q

    # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
    """
    sigma = RowNoise(fit.displacement_noise, fit.load_noise)
    # place: as a number of instants; fit.terms: highest Q, lowest Q, compliance C of the rig, and
    # U0, the origin of the measured U
    place = loops_of_theory.nearest_points(rows, fit.friction, fit.terms, sigma).place
    return np.asarray(np.mod(place / (len(loops_of_theory.load) - 1), 1.0))


def _share_by_load(
    row_loads: Array, is_row_rising: NDArray[np.bool_], fit: MasingFit, load_of_cycle: Array
) -> Array:
    """Share of the scene's cycle that is over where its Q equals that of each row, (n,), on the
    same branch: from lowest to highest Q (rising), or back.

    Parameters
    ----------
    row_loads, is_row_rising
        (n,) Q of the rows, and whether each lies on the rising branch
    fit
        loop fitted to the rows; its lowest and highest Q, to which those of the scene are scaled
    load_of_cycle
        (n_instants,) Q of the scene through a cycle

    # notation: Q tangential load
    """
    load_scale = (fit.highest_load - fit.lowest_load) / float(np.ptp(load_of_cycle))
    # the last instant is the first one again; N_INSTANTS is their number
    lowest_instant = int(np.argmin(load_of_cycle[:-1]))
    highest_instant = int(np.argmax(load_of_cycle[:-1]))
    share_of_cycle = np.empty(len(row_loads))
    for is_branch_rising in (True, False):
        is_on_branch = is_row_rising == is_branch_rising
        first_instant = lowest_instant if is_branch_rising else highest_instant
        last_instant = highest_instant if is_branch_rising else lowest_instant
        if last_instant < first_instant:
            last_instant += N_INSTANTS - 1
        instants = np.arange(first_instant, last_instant + 1)
        # in the order of ascending Q
        if not is_branch_rising:
            instants = instants[::-1]
        branch_loads = load_of_cycle[instants % (N_INSTANTS - 1)]
        load_from_lowest = (row_loads[is_on_branch] - fit.lowest_load) / load_scale
        shares_of_rows = np.interp(
            load_of_cycle[lowest_instant] + load_from_lowest,
            branch_loads,
            instants / (N_INSTANTS - 1),
        )
        share_of_cycle[is_on_branch] = shares_of_rows % 1.0
    return share_of_cycle
