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
from reports.scoring.loop_fit import LoopRows, LoopsOverFriction, Weights, fit_loop
from reports.scoring.loop_fitted import FittedLoop, said_of_scale
from reports.scoring.loop_masing import MasingLoop, MeasuredRows, MemoryCurve, memory_curve
from reports.scoring.loop_masing_fit import BestLoop, MasingFit, best_loop, with_interval
from reports.scoring.loop_rows import MeasuredLoop
from reports.scoring.loop_steadiness import (
    NO_CHANGE,
    Change,
    Misfit,
    differences_of_cycles,
    drift_of_shift,
    goes_on_growing,
)
from reports.scoring.loop_theory import (
    FINE_SHARES,
    INSTANTS,
    cycle_loads,
    has_constant_normal_load,
    least_friction,
    theory_shift,
)
from reports.units import units
from scenes import InputError, Scene
from scenes.array_types import Array

# Error of a fitted f by theory at so many instants, straight between, of itself; and by samples of
# the memory curve. A loop that slides has f from its plateaus, but for round-off in f of sliding.
_OF_THEORY = 1e-5
_OF_MEMORY = 1e-6
_OF_SLIDING = 2e-9
# Part of the distances that is no scatter, over the mean opening of the loop in U, from which rows
# under a varying P are said not to be examined.
_STEADY = 0.02
# The same at constant P, beyond which rows are of no loop of theory; where nearly all of the
# distances is no scatter (a correlation of neighbours above that), a smaller part shows as much.
_OF_THEORY_AT_ALL = 0.015
_NO_SCATTER_AT_ALL = 0.8
_OF_THEORY_WITHOUT_SCATTER = 0.005
# Part of the distances that is no scatter, in sigma of U, below which it is that of nearest points:
# 4 % of sigma were measured where sigma is half of the opening.
_OF_NEAREST_POINTS = 0.1
# Theory's own error of a loop is below this share of its opening.
_WORTH_SAYING = 1e-3
# U that moves on by more than this share of its range in a cycle is no drift of a gauge.
_DRIFT = 0.03
# A drift below this share of the range of U is not worth a word.
_DRIFT_SAID = 1e-3
# Cycles from which on rows before the first turning point are left out.
_MANY_CYCLES = 3.0
# Cycles that are left without a run-in, at least: fewer do not show whether they are alike.
_FEWEST_ALIKE = 2.4
# Half cycles behind the first turning point that are left out, one after the other.
_RUN_IN = (0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 16)
# Chance of scatter alone below which a half cycle more is left out: it costs little; and below
# which the loop is said to change.
_LEFT_OUT = 0.02
_CHANGES = 1e-3
# Chance below which the interval of f holds a change; behind a run-in it always does.
_HELD = 0.05
# Rise of Q along the slide of a gross loop, of its range, that is no plateau.
_NO_PLATEAU = 0.02
# Half cycles: a first row so near to a turning point lies on it, and a first half cycle that is
# shorter goes with the next.
_ON_A_TURN = 0.02
_SHORT_HALF_CYCLE = 0.1


def fit_steady_rows(
    loop: MeasuredLoop, scene: Scene, rig_compliance: float | None
) -> tuple[MeasuredLoop, FittedLoop]:
    """Choose the rows of a measured loop that repeat one steady cycle, and fit the friction
    coefficient f to them.

    Where P varies all rows are fitted. Where it is constant first half-cycles are left out until
    what is left is steady, and a linear drift of U is taken out.

    Parameters
    ----------
    rig_compliance
        C of the rig between the places where U is measured [1/stress]; None fits it

    Returns
    -------
    rows, fit
        the rows that were fitted, and their fit

    Raises
    ------
    InputError
        Where the rows are of no steady loop of theory.
    """
    if not has_constant_normal_load(scene):
        # Distances from the nearest point of a loop are no scatter beside its turning points: three
        # of twenty good loops with noise were refused by them.
        fit = _fit_where_load_varies(loop, scene, rig_compliance)
        share_of_opening = _share_of_opening(loop, fit.misfit, fit.phase)
        sentence = "P varies: the rows were not examined for drift, run-in and cycles that differ"
        if share_of_opening > _STEADY or _cycles_differ(loop):
            fit = replace(fit, said=(*fit.said, sentence))
        return loop, _with_widening_said(fit, share_of_opening)

    drift = _drift_of_cycle(loop)
    if drift:
        raise InputError(
            f"{loop.source}: its rows are of no steady loop: U moves on by {100 * drift:+.2g} % of"
            " its range in each cycle, so the contact slides on or the gauge does; give the rows of"
            " cycles that are alike"
        )
    curve = memory_curve(scene, least_friction(scene) / float(np.ptp(cycle_loads(scene)[1])))
    chosen_candidate = _steadiest(loop, curve, rig_compliance)
    if rig_compliance is None:
        _require_a_loop_of_theory(chosen_candidate, loop, scene)
    chosen_rows, fit = _fit_at_constant_load(chosen_candidate, scene, curve)
    fit = replace(fit, cycles=_branches_of_both(loop).cycles)
    if chosen_candidate.share > _OF_THEORY_AT_ALL:
        sentence = (
            f"With the stated rig compliance the best fit is {100 * chosen_candidate.share:.2g} %"
            " of the loop's opening away from rows that lie beside each other: leave it out, and it"
            " is fitted"
        )
        fit = replace(fit, said=(*fit.said, sentence))
    return chosen_rows, _with_widening_said(
        _with_change(fit, chosen_candidate), chosen_candidate.share
    )


def _steadiest(loop: MeasuredLoop, curve: MemoryCurve, rig_compliance: float | None) -> _Candidate:
    """The rows of a measured loop that repeat one cycle, with the loop of theory that fits them:
    the first that are steady, as more and more half-cycles are left out at the begin; else those
    that are nearest to it.

    Parameters
    ----------
    curve
        half-plane theory's displacement over load, from which every branch of the loop follows
    rig_compliance
        C of the rig between the places where U is measured [1/stress]; None fits it

    Raises
    ------
    InputError
        Where the cycles differ or go on growing however many are left out.
    """
    candidates = []
    growth_words = ""
    difference_of_cycles = _cycles_differ(loop)
    for rows_without_run_in in _without_run_in(loop):
        growth_here = rows_without_run_in.goes_on_growing
        if growth_here:
            growth_words = growth_here
            continue
        difference_here = _cycles_differ(rows_without_run_in.rows)
        if difference_here:
            difference_of_cycles = difference_of_cycles or difference_here
            continue
        candidate = _candidate(rows_without_run_in, curve, rig_compliance)
        candidates.append(candidate)
        if candidate.is_steady:
            break
    if not candidates or (growth_words and not candidates[-1].is_steady):
        reason = difference_of_cycles
        if growth_words not in reason:
            reason = (
                f"its cycles {growth_words}, and its noise is too large to tell whether the last"
                " ones still do"
            )
        raise InputError(
            f"{loop.source}: its rows are of no steady loop: {reason}; give the rows of cycles that"
            " are alike"
        )
    if candidates[-1].is_steady:
        return candidates[-1]
    return min(candidates, key=lambda candidate: candidate.unsteady_share)


# ------------------------------------------------------------------ rows that may be a steady loop
@dataclass(frozen=True, eq=False)
class _Candidate:
    """Rows without a run-in, and what fits them.

    Attributes
    ----------
    share
        part of the distances that is no scatter, over the loop's mean opening in U
    rows
        the measured rows that are left
    branches
        turning points of Q and the branch of each row
    best
        the fitted loop
    said
        what was left out, in words
    had_run_in
        whether more than the rows before the first turning point were left out
    change_with_time, change_of_first_half, change_by_turns
        how the loop changes with time [cycles], between its first half cycle and the others, and
        from one cycle to the next but one
    change_of_size
        how U and Q grow with time, over themselves
    log_friction_at_end
        by how much ln f at the end differs for it
    sigma_over_opening
        of U
    """

    share: float
    rows: MeasuredLoop
    branches: Branches
    best: BestLoop
    said: str
    had_run_in: bool
    change_with_time: Change
    change_of_first_half: Change
    change_by_turns: Change
    change_of_size: Change
    log_friction_at_end: float
    sigma_over_opening: float

    @property
    def is_steady(self) -> bool:
        """Whether nothing shows that the loop changes; its form is judged once, on these rows."""
        chances = (
            self.change_with_time.chance,
            self.change_of_first_half.chance,
            self.change_of_size.chance,
        )
        return min(chances) > _LEFT_OUT

    @property
    def unsteady_share(self) -> float:
        """Of the distances, over the loop's opening: what is no scatter, or what a change with time
        explains.
        """
        share_by_change = self.change_with_time.rms * self.sigma_over_opening
        return max(self.share, share_by_change)

    @property
    def rises_along_slide(self) -> float:
        """By how much Q rises while the contact slides as a whole, of its range; 0 where it has a
        plateau, or where scatter gives as much.
        """
        if not self.best.gross:
            return 0.0
        rise, change = self.best.rise_along_slide()
        return rise if change.chance < _CHANGES and rise > _NO_PLATEAU else 0.0

    def shows(self, change: Change) -> bool:
        """Whether the loop changes so, and not by chance, by more than theory may miss."""
        size = change.rms * self.sigma_over_opening
        return change.chance < _CHANGES and size > _OF_THEORY_AT_ALL


def _candidate(
    without_run_in: _WithoutRunIn, curve: MemoryCurve, rig_compliance: float | None
) -> _Candidate:
    """Fit the loop of theory to the rows that are left without a run-in, and test whether these are
    steady: whether f, U or Q change with time, whether the first half-cycle differs, and whether
    every second cycle does.

    Parameters
    ----------
    without_run_in
        the rows that are left, and what was left out
    curve
        memory curve of theory, from which loops are built
    rig_compliance
        C of the rig [1/stress]; None fits it
    """
    loop_rows = without_run_in.rows
    branches = _branches_of_both(loop_rows)
    rows_to_fit = MeasuredRows(
        loop_rows.shift,
        loop_rows.load,
        loop_rows.time,
        branches,
        rig_compliance,
        loop_rows.resolution,
    )
    best_fit = best_loop(rows_to_fit, curve)
    change_with_time = NO_CHANGE
    change_of_first_half_cycle = NO_CHANGE
    change_every_second_cycle = NO_CHANGE
    change_of_size = NO_CHANGE
    log_friction_at_end = 0.0
    # too few cycles show no change with time
    if branches.cycles >= _FEWEST_ALIKE:
        phase = np.maximum.accumulate(branches.phase)
        first_turn = math.ceil(2 * phase[0] + _ON_A_TURN) / 2
        if first_turn - phase[0] < _SHORT_HALF_CYCLE:
            first_turn += 0.5
        change_with_time = best_fit.change_with(phase)
        change_of_first_half_cycle = best_fit.change_with((phase < first_turn).astype(float))
        alternating_changes = [
            best_fit.change_with(wave(np.pi * phase)) for wave in (np.cos, np.sin)
        ]
        change_every_second_cycle = min(alternating_changes, key=lambda change: change.chance)
        change_of_size = best_fit.change_of_size_with(phase)
        log_friction_at_end = best_fit.log_friction_at_end(change_of_size.terms, phase)
    share_of_opening = _share_of_opening(loop_rows, best_fit.misfit, branches.phase)
    sigma_over_opening = best_fit.search.weights.shift / _opening(loop_rows, branches.phase)
    # no more than noise moves the nearest points of the loop
    if share_of_opening < _OF_NEAREST_POINTS * sigma_over_opening:
        share_of_opening = 0.0
    return _Candidate(
        share=share_of_opening,
        rows=loop_rows,
        branches=branches,
        best=best_fit,
        said=without_run_in.said,
        had_run_in=without_run_in.half_cycles > 0,
        change_with_time=change_with_time,
        change_of_first_half=change_of_first_half_cycle,
        change_by_turns=change_every_second_cycle,
        change_of_size=change_of_size,
        log_friction_at_end=log_friction_at_end,
        sigma_over_opening=sigma_over_opening,
    )


def _require_a_loop_of_theory(candidate: _Candidate, loop: MeasuredLoop, scene: Scene) -> None:
    """Raise InputError, with the reason, where even the best fit lies so far beside the rows, as a
    share of the loop's opening, that theory has no such steady loop. `loop` holds all rows.

    Parameters
    ----------
    candidate
        the fit of the rows that were chosen, with the tests of their steadiness
    """
    misfit = candidate.best.misfit
    limit = _OF_THEORY_AT_ALL
    if misfit.correlation > _NO_SCATTER_AT_ALL and not candidate.best.hangs_on_digits:
        limit = _OF_THEORY_WITHOUT_SCATTER
    reason = ""
    if candidate.shows(candidate.change_by_turns):
        reason = "its period is another: every second cycle is alike"
    elif candidate.shows(candidate.change_with_time) or candidate.shows(candidate.change_of_size):
        growth = 100 * candidate.change_of_size.terms * candidate.branches.cycles
        reason = (
            f"its cycles change to the end: U grows by {growth[0]:+.2g} % and Q by"
            f" {growth[1]:+.2g} % over {candidate.branches.cycles:.2g} cycles"
        )
    elif candidate.rises_along_slide:
        reason = (
            f"its Q rises by {100 * candidate.rises_along_slide:.2g} % of its range while the"
            " contact slides as a whole: it hardens (plastic flow, debris, or a pad that tilts),"
            " and has no plateau at f P"
        )
    elif candidate.share > limit:
        reason = (
            "its cycles are alike, but their form is not that of theory (other bodies, plastic"
            " flow, wear, or noise that is no scatter)"
        )
    if not reason:
        return
    largest_share = max(candidate.share, candidate.unsteady_share)
    raise InputError(
        f"{loop.source}: its rows are of no steady loop of {scene.name}:"
        f" {_cycles_differ(loop) or reason}; the best fit is {100 * largest_share:.2g} % of the"
        f" loop's opening away from rows that lie beside each other (limit {100 * limit:.2g} %)"
    )


def _with_change(fit: FittedLoop, candidate: _Candidate) -> FittedLoop:
    """The fit of a measured loop with its interval of f widened by how much f still changes up to
    the last row; as it is where no such change was found.

    `candidate` is the fit with the tests of its rows' steadiness.
    """
    log_friction_change = candidate.log_friction_at_end
    if candidate.change_of_size.chance > _HELD and not candidate.had_run_in:
        return fit
    friction_change = fit.friction * math.expm1(min(abs(log_friction_change), 1.0))
    sentence = (
        "The loop still changes over the rows that are left, f by"
        f" {100 * math.expm1(min(log_friction_change, 1.0)):+.2g} % to the last one: the interval"
        " of f holds it"
    )
    lowest_friction = fit.friction - math.hypot(fit.friction - fit.low, friction_change)
    highest_friction = (
        None
        if fit.high is None
        else fit.friction + math.hypot(fit.high - fit.friction, friction_change)
    )
    return replace(
        fit, low=max(lowest_friction, 0.0), high=highest_friction, said=(*fit.said, sentence)
    )


@dataclass(frozen=True, eq=False)
class _WithoutRunIn:
    """Rows that may be of one steady loop: all from the row `first` of `every_row` on; what was
    done, in words.
    """

    every_row: MeasuredLoop
    first: int
    half_cycles: int
    said: str

    @property
    def rows(self) -> MeasuredLoop:
        """Those that are left."""
        loop = self.every_row
        return replace(
            loop,
            shift=loop.shift[self.first :],
            load=loop.load[self.first :],
            time=loop.time[self.first :],
        )

    @property
    def goes_on_growing(self) -> str:
        """Whether what was left out is no run-in, since the rest may grow or shrink as all rows do;
        in a word.
        """
        if not self.half_cycles:
            return ""
        loop = self.every_row
        return goes_on_growing(loop.shift, loop.load, loop.time, self.first, _noise_of_load(loop))


def _without_run_in(loop: MeasuredLoop) -> Iterator[_WithoutRunIn]:
    """A measured loop with ever more of its first half-cycles left out, as a run-in, and a sentence
    on what was. The whole loop comes first, where it has few cycles.
    """
    phase = np.maximum.accumulate(_branches_of_both(loop).phase)
    if phase[-1] - phase[0] < _MANY_CYCLES:
        yield _WithoutRunIn(loop, 0, 0, "")
    first_turn = math.ceil(2 * phase[0] + _ON_A_TURN) / 2
    for half_cycles in _RUN_IN:
        first_row = int(np.argmax(phase >= first_turn + half_cycles / 2))
        if phase[-1] - phase[first_row] < _FEWEST_ALIKE or not first_row:
            return
        sentence = f"Rows 1 to {first_row} are left out: run-in, unlike the later cycles"
        if not half_cycles:
            sentence = (
                f"Rows 1 to {first_row}, before the first turning point, are left out: they may be"
                " of the initial loading"
            )
        yield _WithoutRunIn(loop, first_row, half_cycles, sentence)


def _branches_of_both(loop: MeasuredLoop) -> Branches:
    """Branches of the rows by U and Q together, each over its range: their sum has its turning
    points where the branches have theirs, also where Q stays while the contact slides.
    """
    range_of_shift = float(np.ptp(loop.shift))
    range_of_load = float(np.ptp(loop.load))
    both = loop.shift / range_of_shift + loop.load / range_of_load
    step = loop.resolution[0] / range_of_shift + loop.resolution[1] / range_of_load
    return find_branches(loop.shift, both, loop.time, step, loop.source)


def _share_of_opening(loop: MeasuredLoop, misfit: Misfit, phase: Array) -> float:
    """The part of the distances that is no scatter over the mean opening of the loop in U."""
    return misfit.systematic / _opening(loop, phase)


def _opening(loop: MeasuredLoop, phase: Array) -> float:
    """Mean opening of the loop in U [length]."""
    area = polygon_area(loop.shift, loop.load, phase, 0.0, 0.0).value
    return max(abs(area), 1e-300) / float(np.ptp(loop.load))


def _cycles_differ(loop: MeasuredLoop) -> str:
    """How the cycles differ, in words; "" where they do not."""
    return differences_of_cycles(loop.shift, loop.load, loop.time, _noise_of_load(loop))


def _noise_of_load(loop: MeasuredLoop) -> float:
    """Sigma of Q, by neighbouring rows and by its digits."""
    return max(row_noise(loop.load), loop.resolution[1] / math.sqrt(12))


def _with_widening_said(fit: FittedLoop, share: float) -> FittedLoop:
    if fit.misfit.widening == 1.0 or share < _WORTH_SAYING:
        return fit
    sentence = (
        "Neighbouring rows lie on the same side of the best fit (correlation"
        f" {fit.misfit.correlation:.2g}), by {100 * share:.2g} % of the loop's opening: the"
        f" interval of f is {fit.misfit.widening:.2g} times as wide for it"
    )
    return replace(fit, said=(*fit.said, sentence))


def _drift_of_cycle(loop: MeasuredLoop) -> float:
    """Of U in a cycle, over its range, where it is no drift of a gauge; else 0."""
    branches = find_branches(loop.shift, loop.load, loop.time, loop.resolution[1], loop.source)
    rate = drift_of_shift(loop.shift, loop.load, loop.time, branches)
    if rate is None:
        return 0.0
    range_of_shift = float(np.ptp(loop.shift))
    drift = rate * float(np.ptp(loop.time)) / branches.cycles / range_of_shift
    by_noise = 2 * row_noise(loop.shift) / range_of_shift
    return drift if abs(drift) > _DRIFT + by_noise else 0.0


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
        the rows that were chosen, in cycles that repeat, and the loop that fits them best
    scene
        gives the tangential load Q over the cycle, to which the measured one is scaled
    curve
        half-plane theory's displacement over load, from which every branch of the loop follows
    """
    loop = candidate.rows
    branches = candidate.branches
    fit = with_interval(candidate.best, _OF_SLIDING if candidate.best.gross else _OF_MEMORY)
    share_of_time = (loop.time - loop.time[0]) / float(np.ptp(loop.time))
    rows_without_drift = replace(loop, shift=loop.shift - fit.drift * (share_of_time - 0.5))
    load_of_cycle = cycle_loads(scene)[1]
    scale = (fit.highest - fit.lowest) / float(np.ptp(load_of_cycle))
    which_rows = " that are left" if candidate.said else ""
    sentences = [
        (
            f"The rows{which_rows} cover {branches.cycles:.4g} cycles between Q = {fit.lowest:.6g}"
            f" and {fit.highest:.6g}; P is constant, so that the form of Q and U over time"
            " counts for nothing"
        ),
        *said_of_scale(scale),
    ]
    if candidate.said:
        sentences.append(candidate.said)
    range_of_shift = float(np.ptp(loop.shift))
    drift_uncertainty = 1.96 * fit.drift_error
    if abs(fit.drift) > max(drift_uncertainty, _DRIFT_SAID * range_of_shift):
        sentences.append(
            f"U drifts by {100 * fit.drift / range_of_shift / branches.cycles:+.2g} % of its range"
            " in a cycle: taken out"
        )
    if fit.gross:
        sentences.append(
            f"The contact slides as a whole by {fit.slide:.3g} {units(scene)[1]} at each end of the"
            f" loop: f is Q/P there, with Q = {(fit.highest - fit.lowest) / 2:.6g} from the middle"
        )
    if fit.gross:
        share_of_cycle = np.mod(fit.distances.place / 2 + 0.5, 1.0)
    else:
        share_of_cycle = _share_by_load(loop.load, fit.distances.place < 1, fit, load_of_cycle)
    return rows_without_drift, FittedLoop(
        scene=scene,
        friction=fit.friction,
        low=fit.low,
        high=fit.high,
        compliance=fit.compliance,
        share=share_of_cycle,
        phase=branches.phase,
        cycles=branches.cycles,
        scale=scale,
        offset=fit.lowest - scale * float(load_of_cycle.min()),
        shift_noise=fit.weights.shift,
        load_noise=fit.weights.load,
        said=tuple(sentences),
        misfit=fit.misfit,
        model=MasingLoop(curve, fit.parameters),
        masing=fit,
        gross=fit.gross,
    )


def _fit_where_load_varies(
    loop: MeasuredLoop, scene: Scene, rig_compliance: float | None
) -> FittedLoop:
    """Fit f to a measured loop whose scene has a varying P and two branches of Q in a cycle:
    theory's loop between the turning points of Q is fitted to the rows. `rig_compliance` is C of
    the rig; None fits it too.
    """
    branches = find_branches(loop.shift, loop.load, loop.time, loop.resolution[1], loop.source)
    rows = LoopRows(loop.shift, loop.load, branches, rig_compliance)
    load_of_cycle = cycle_loads(scene)[1]
    load_at_fine_instants = cycle_loads(scene, FINE_SHARES)[1]
    model = LoopsOverFriction(
        load_at_fine_instants,
        least_friction(scene),
        lambda friction: theory_shift(scene, friction, FINE_SHARES),
    )
    fit = fit_loop(rows, model, loop.resolution, _OF_THEORY)
    weights = Weights(fit.shift_noise, fit.load_noise)
    nearest_points = model.nearest_points(rows, fit.friction, fit.terms, weights)
    scale = (fit.highest - fit.lowest) / float(np.ptp(load_of_cycle))
    sentences = [
        (
            f"The rows cover {branches.cycles:.4g} cycles between Q = {fit.lowest:.6g} and"
            f" {fit.highest:.6g}; P was taken over Q as in the scene, so that the form of Q and U"
            " over time counts for nothing"
        ),
        *said_of_scale(scale),
    ]
    return FittedLoop(
        scene=scene,
        friction=fit.friction,
        low=fit.low,
        high=fit.high,
        compliance=fit.compliance,
        share=np.mod(nearest_points.place / (len(load_at_fine_instants) - 1), 1.0),
        phase=branches.phase,
        cycles=branches.cycles,
        scale=scale,
        offset=fit.lowest - scale * float(load_of_cycle.min()),
        shift_noise=fit.shift_noise,
        load_noise=fit.load_noise,
        said=tuple(sentences),
        misfit=fit.misfit,
    )


def _share_by_load(
    load: Array, row_rises: NDArray[np.bool_], fit: MasingFit, load_of_cycle: Array
) -> Array:
    """Share of the scene's cycle that is over where its Q equals that of each row, (n,), on the
    same branch.

    Parameters
    ----------
    load, row_rises
        (n,) Q of the rows, and whether each lies on the rising branch
    fit
        gives the turning points of the rows
    load_of_cycle
        (n_instants,) Q of the scene through a cycle
    """
    scale = (fit.highest - fit.lowest) / float(np.ptp(load_of_cycle))
    lowest_instant = int(np.argmin(load_of_cycle[:-1]))
    highest_instant = int(np.argmax(load_of_cycle[:-1]))
    share_of_cycle = np.empty(len(load))
    for rising in (True, False):
        is_on_branch = row_rises == rising
        begin = lowest_instant if rising else highest_instant
        end = highest_instant if rising else lowest_instant
        if end < begin:
            end += INSTANTS - 1
        instants = np.arange(begin, end + 1)
        if not rising:
            instants = instants[::-1]
        loads_of_branch = load_of_cycle[instants % (INSTANTS - 1)]
        load_of_scene = load_of_cycle[lowest_instant] + (load[is_on_branch] - fit.lowest) / scale
        share_of_cycle[is_on_branch] = (
            np.interp(load_of_scene, loads_of_branch, instants / (INSTANTS - 1)) % 1.0
        )
    return share_of_cycle
