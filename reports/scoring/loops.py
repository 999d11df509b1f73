"""A measured loop of Q over the relative displacement U as the reference: which f fits it, and how
theory and finite elements lie.

# notation: A = 2/E*, C compliance of the rig, f friction coefficient, r factor of the file's Q over
#           the scene's, W area of the loop, tau time on the scene's cycle

A rig measures U beside the loads, and in it its own elastic compliance:

    U = r U(tau; f/r) + C Q + U0 + noise,   Q = r Q(tau) + Q0 + noise

where U(tau; f) is that of the steady cycle of the scene. Loads that are r times as large with the
same f slip as those of the scene with f/r. U of half-planes hangs on a datum length by a term that
is linear in Q at constant P: a fitted C takes it in, a given one is that of the rig beyond
`profile.datum_length`.

The way of a loop: its rows are read (`loop_rows`). Where Q has one highest and one lowest value in
a cycle, nothing depends on the form of Q or U over time: rows have a branch by their order
(`loop_branches`), those of a run-in are left out, and those of no steady loop are refused
(`loop_steady_rows`). They lie where theory's loop is nearest: at constant P that of Masing's rule,
which may slide as a whole at its ends (`loop_masing`); else that of the scene, with P over Q as
there (`loop_fit`). Where Q has more turning points in a cycle, rows are placed by their times
(`loop_over_time`). Here the loops of the engines are laid beside the rows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from reports.scoring.loop_area import area_about_fit, polygon_area
from reports.scoring.loop_fitted import FittedLoop, fit_rig
from reports.scoring.loop_masing import MasingLoop
from reports.scoring.loop_over_time import fit_over_time
from reports.scoring.loop_rows import MeasuredLoop, read_loop
from reports.scoring.loop_steady_rows import fit_steady_rows
from reports.scoring.loop_theory import (
    SHARES_OF_CYCLE,
    cycle_loads,
    finite_element_displacement,
    friction_at_gross_sliding,
    has_two_branches,
    theory_displacement,
)
from scenes import InputError, Scene
from scenes.array_types import Array
from scenes.measured import ReadAs

__all__ = [
    "WITH_SCENE_FRICTION",
    "SHARES_OF_CYCLE",
    "Against",
    "LoopRow",
    "LoopScore",
    "MeasuredLoop",
    "means_of_parts",
    "read_loop",
    "require_loop",
    "score_loop",
]

Against = Literal["exact", "fe"]
WITH_SCENE_FRICTION = "the scene's f"
"""Which f a computed loop has, in the name of its row."""

# Number of parts of the cycle in which rows are averaged for the figures, at most.
_MOST_PARTS_OF_CYCLE = 200


@dataclass(frozen=True)
class LoopRow:
    """One loop: area W [energy per thickness] and its uncertainty, slope dU/dQ of the straight line
    through it [1/stress].

    `friction` is its coefficient, None of the measured one; `distance` the root mean square of its
    distances in U from the means of the rows in each part of the cycle [length], NaN of the
    measured one. `by_distance` and `by_noise` are the parts of `area_uncertainty`: what lies
    between the rows of the polygon, and 95 % of their scatter.
    """

    name: str
    friction: float | None
    area: float
    area_uncertainty: float
    slope: float
    distance: float
    by_distance: float = 0.0
    by_noise: float = 0.0


class LoopCurve(NamedTuple):
    """A computed loop for the figure: U with the rig, and Q, (n_instants,) each."""

    name: str
    displacement: Array
    load: Array


@dataclass(frozen=True, eq=False)
class LoopScore:
    """The friction coefficient f that a measured loop shows, and the loops computed beside it.

    Attributes
    ----------
    scene
        the scene that the loop was scored against
    source
        file of the loop
    friction, lowest_friction, highest_friction
        f that fits best, and the ends of its 95 % interval; the upper one is None where the rows
        exclude no larger f
    compliance, is_compliance_fitted
        C of the rig [1/stress], and whether it was fitted
    scale
        r, the file's Q over the scene's
    n_cycles
        number of cycles that the rows cover
    noise
        standard deviation of the noise of U [length]
    loops
        a row of the table of loops each: the measured one first, then the computed ones
    read_as
        how the file was read
    notes
        sentences on what was assumed or left out
    share_of_cycle, displacement, load
        (n,) share of the cycle that is over, U and Q of the measured rows
    curves
        the computed loops, for the figure
    """

    scene: Scene
    source: str
    friction: float
    lowest_friction: float
    highest_friction: float | None
    compliance: float
    is_compliance_fitted: bool
    scale: float
    n_cycles: float
    noise: float
    loops: tuple[LoopRow, ...]
    read_as: ReadAs
    notes: tuple[str, ...]
    share_of_cycle: Array
    displacement: Array
    load: Array
    curves: tuple[LoopCurve, ...]

    @property
    def is_scene_friction_within(self) -> bool:
        """Whether the scene's own f lies in the interval."""
        return (
            self.lowest_friction
            <= self.scene.friction.coefficient
            <= (math.inf if self.highest_friction is None else self.highest_friction)
        )

    @property
    def sentence(self) -> str:
        """The finding on a measured loop in one sentence: the friction coefficient f that fits
        best, its 95 % interval, and whether the scene's f lies in it. The best f and the ends of
        the interval have as many digits as they need to differ, at least four.
        """
        frictions = [self.lowest_friction, self.friction]
        if self.highest_friction is not None:
            frictions.append(self.highest_friction)
        digits = 4
        while digits < 16:
            if len({f"{friction:.{digits}g}" for friction in frictions}) == len(set(frictions)):
                break
            digits += 1
        upper_end = (
            "no upper limit"
            if self.highest_friction is None
            else f"{self.highest_friction:.{digits}g}"
        )
        verdict = "lies within" if self.is_scene_friction_within else "lies outside"
        return (
            f"The loop is best fitted by f = {self.friction:.{digits}g} (95 %:"
            f" {self.lowest_friction:.{digits}g} to {upper_end}); the scene's f ="
            f" {self.scene.friction.coefficient:.{max(digits, 4)}g} {verdict} this interval."
        )


def require_loop(scene: Scene) -> None:
    """InputError for a scene that no measured loop can be scored against: whose loads do not
    repeat, or with bulk stress, tilt or bodies of unequal sides.
    """
    if scene.load.path().period is None:
        raise InputError(f"{scene.name}: its loads do not repeat: a loop needs a cycle")
    if scene.unsymmetric:
        raise InputError(
            f"{scene.name}: no measured loop is scored with bulk stress, tilt or unequal sides: U"
            " hangs on where it is measured, and the loop's area is not the dissipation"
        )


def score_loop(
    loop: MeasuredLoop,
    scene: Scene,
    *,
    rig_compliance: float | None = None,
    against: Against = "exact",
) -> LoopScore:
    """The friction coefficient f that fits a measured loop of Q over U best, with its 95 %
    interval; and beside it the loops that theory computes, and finite elements where they are asked
    for.

    Parameters
    ----------
    loop
        Q and the relative tangential displacement U of the rows, their time, and the file `source`
    scene
        its cycle of P and Q, profile and material are those of theory's loops
    rig_compliance
        compliance C of the rig [1/stress], which adds C Q to the displacement U of the contact; U
        counts from the datum length of the profile. None fits C
    against
        "fe": loops of the finite elements too, with the scene's f and the best one; none where the
        contact slides as a whole

    Raises
    ------
    InputError
        For a scene whose loads do not repeat or have no Q, or with bulk stress, tilt or bodies of
        unequal sides; for rows whose U or Q is constant, that cover less than a cycle, or that do
        not follow the scene's Q.

    Examples
    --------
    >>> import semi_analytic
    >>> from scenes import load_scene
    >>> scene = load_scene("cattaneo-mindlin")  # f = 0.5
    >>> path, row_times = scene.load.path(), np.arange(200) / 100
    >>> times = path.cycle_start + path.period * (1 + np.arange(101) / 100)
    >>> exact = semi_analytic.solve(scene, x=0.0, time=times, fields="tangential_displacement")
    >>> instants = np.arange(200) % 100  # of the rows, two cycles of 100
    >>> loads = exact.tangential_load[instants]
    >>> displacements = exact.tangential_displacement[instants] + 1e-5 * loads  # C = 1e-5
    >>> score = score_loop(MeasuredLoop("rig.csv", displacements, loads, row_times), scene)
    >>> round(score.friction, 3), round(score.compliance, 7)
    (0.5, 1e-05)

    # notation: P normal load, Q tangential load
    """
    require_loop(scene)
    for name, values in (("U", loop.displacement), ("Q", loop.load)):
        if not np.ptp(values) > 0:
            raise InputError(f"{loop.source}: {name} is the same in every row: there is no loop")
    # Q rises once and falls once in a cycle: the order of the rows tells their place on the loop
    if has_two_branches(scene):
        loop, fit = fit_steady_rows(loop, scene, rig_compliance)
    else:
        # more turning points of Q: rows are placed by their times
        fit = fit_over_time(loop, scene, rig_compliance)
    # area and slope of the measured loop
    table_row_of_measured, sentence = _row_of_measured_loop(loop, fit)
    # at the ends of the loop the contact slides as a whole
    if fit.is_gross and fit.masing_loop is not None:
        computed_loops = _sliding_loops(loop, fit, fit.masing_loop, scene, against)
    else:
        computed_loops = _partial_loops(loop, fit, scene, rig_compliance, against)
    return LoopScore(
        scene=fit.scene,
        source=loop.source,
        friction=fit.friction,
        lowest_friction=fit.lowest_friction,
        highest_friction=fit.highest_friction,
        compliance=fit.compliance,
        is_compliance_fitted=rig_compliance is None,
        scale=fit.load_scale,
        n_cycles=fit.n_cycles,
        noise=fit.displacement_noise,
        loops=(table_row_of_measured, *(computed.table_row for computed in computed_loops.loops)),
        read_as=loop.read_as,
        # what was assumed or left out
        notes=(*fit.sentences, sentence, *computed_loops.sentences),
        share_of_cycle=fit.share_of_cycle,
        displacement=loop.displacement,
        load=loop.load,
        curves=tuple(
            LoopCurve(computed.table_row.name, computed.displacement, computed.load)
            for computed in computed_loops.loops
        ),
    )


# ------------------------------------------------------------------------------- the measured loop
def _row_of_measured_loop(measured_loop: MeasuredLoop, fit: FittedLoop) -> tuple[LoopRow, str]:
    """The measured loop of Q over U as a row of the table of loops (area W with its uncertainty,
    slope dU/dQ; no coefficient of friction and no distance from itself), and a sentence on how W
    was computed.

    Parameters
    ----------
    measured_loop
        U and Q of the n measured rows
    fit
        the loop fitted to them: `cycles_passed` (n,), cycles that have passed at each row;
        `share_of_cycle` (n,), place on the scene's cycle; noise of U and Q; `load_scale`, the
        file's Q over the scene's; `masing_loop` and its fit, None where P varies

    # notation: P normal load, Q tangential load, U relative tangential displacement
    """
    # only a loop of Masing's rule, at constant P, has an area of its own
    if fit.masing_loop is None or fit.masing_fit is None:
        loop_area = polygon_area(
            measured_loop.displacement,
            measured_loop.load,
            fit.cycles_passed,
            fit.displacement_noise,
            fit.load_noise,
        )
        method_words = "the area of the polygon of the rows"
    else:
        loop_area = area_about_fit(
            fit.masing_loop, fit.masing_fit, float(fit.cycles_passed[-1] - fit.cycles_passed[0])
        )
        method_words = "the area of the best fit, with what the rows enclose beside it,"
    # Q of the scene at shares of a cycle from 0 to 1 (SHARES_OF_CYCLE), scaled
    _, load_of_scene = cycle_loads(fit.scene)
    load_of_cycle = fit.load_scale * load_of_scene
    table_row = LoopRow(
        name="measured",
        friction=None,
        area=loop_area.value,
        area_uncertainty=loop_area.uncertainty,
        slope=_slope_of_line(
            measured_loop.displacement,
            np.interp(fit.share_of_cycle, SHARES_OF_CYCLE, load_of_cycle),
        ),
        distance=math.nan,
        by_distance=loop_area.error_by_distance,
        by_noise=loop_area.error_by_scatter,
    )
    sentence = (
        f"W as measured is {method_words} over {loop_area.n_cycles}"
        f" {'cycle' if loop_area.n_cycles == 1 else 'cycles'}:"
        f" ± {loop_area.error_by_distance:.2g} by what lies between rows,"
        f" ± {loop_area.error_by_scatter:.2g} by their scatter (95 %)"
    )
    return table_row, sentence


# ------------------------------------------------------------------------- computed loops beside it
@dataclass(frozen=True, eq=False)
class _ComputedLoop:
    """A loop of theory or finite elements beside the measured one: its row of the table, U with the
    rig, and Q (n_instants,).
    """

    table_row: LoopRow
    displacement: Array
    load: Array


class _ComputedLoops(NamedTuple):
    """The computed loops, and what was left out, in words."""

    loops: list[_ComputedLoop]
    sentences: list[str]


def _partial_loops(
    measured_loop: MeasuredLoop,
    fit: FittedLoop,
    scene: Scene,
    rig_compliance: float | None,
    against: Against,
) -> _ComputedLoops:
    """Loops beside a measured one that slips partially: what theory, and with `against` "fe" the
    finite elements, compute under the loads of the rows, with the best friction coefficient f and
    with the scene's f. With them a sentence for each f at which the contact would slide as a whole.

    `rig_compliance` is the stated compliance C of the rig; None fits C to the rows for each loop.

    # notation: P normal load, Q tangential load, U relative tangential displacement
    """
    loops = []
    sentences = []
    # WITH_SCENE_FRICTION: words for the scene's f
    for name, trial_friction in (
        ("best f", fit.friction),
        (WITH_SCENE_FRICTION, scene.friction.coefficient),
    ):
        # The scene's Q is that of the rows over `fit.load_scale`, at the same P. With f over it
        # too, shear and U are smaller by that factor everywhere.
        friction_at_scene_q = trial_friction / fit.load_scale
        if friction_at_scene_q < friction_at_gross_sliding(scene):
            sentences.append(
                f"With {name}, {trial_friction:.4g}, the measured loads slide grossly: there is no"
                " such loop"
            )
            continue
        # U through the cycle, by name of the loop (the engine and its f), as the table names it
        displacements = {f"theory, {name}": theory_displacement(fit.scene, friction_at_scene_q)}
        if against == "fe":
            displacements[f"finite elements, {name}"] = finite_element_displacement(
                fit.scene, friction_at_scene_q
            )
        loops += [
            # _LoopOfScene: name, f at the loads of the rows, U at those of the scene
            _loop_with_rig(
                measured_loop,
                fit,
                _LoopOfScene(name_of_loop, trial_friction, displacement),
                rig_compliance,
            )
            for name_of_loop, displacement in displacements.items()
        ]
    return _ComputedLoops(loops, sentences)


class _LoopOfScene(NamedTuple):
    """U (n_instants,) of an engine at the loads of the scene, under a name; f at those of the
    rows.
    """

    name: str
    friction: float
    displacement: Array


def _loop_with_rig(
    measured_loop: MeasuredLoop,
    fit: FittedLoop,
    computed_loop: _LoopOfScene,
    rig_compliance: float | None,
) -> _ComputedLoop:
    """A computed loop with the rig added, U = r U_computed + C Q + U0, with the compliance C and
    the origin U0 such that it lies nearest to the rows; with its area W, slope dU/dQ and distance
    from the rows. A stated `rig_compliance` (C) is kept.

    Parameters
    ----------
    measured_loop
        the measured rows
    fit
        places of the rows on the cycle, and r, the file's Q over the scene's
    computed_loop
        name, f, and U through a cycle of the scene

    # notation: C compliance of the rig, f coefficient of friction, Q tangential load, U relative
    #           tangential displacement
    """
    # Q of the scene through a cycle
    _, load_of_scene = cycle_loads(fit.scene)
    load = fit.load_scale * load_of_scene
    # C and U0 by least squares over the rows
    _, compliance, origin = fit_rig(
        measured_loop,
        computed_loop.displacement,
        fit.share_of_cycle,
        load,
        fit.load_scale,
        rig_compliance,
    )
    displacement_with_rig = fit.load_scale * computed_loop.displacement + compliance * load + origin
    # the rig is elastic: it adds nothing to the area
    mean_load = (load_of_scene[1:] + load_of_scene[:-1]) / 2
    area = fit.load_scale**2 * float(np.sum(mean_load * np.diff(computed_loop.displacement)))
    slope, distance = _slope_and_distance(
        measured_loop, fit.share_of_cycle, displacement_with_rig, load
    )
    # name, f, W and its uncertainty, slope, distance
    table_row = LoopRow(computed_loop.name, computed_loop.friction, area, 0.0, slope, distance)
    # offset: the file's Q is r times the scene's plus this
    return _ComputedLoop(table_row, displacement_with_rig, load + fit.offset)


def _sliding_loops(
    measured_loop: MeasuredLoop,
    fit: FittedLoop,
    fitted_loop: MasingLoop,
    scene: Scene,
    against: Against,
) -> _ComputedLoops:
    """The loops beside a measured one that slides as a whole: the fitted one (`fitted_loop`), and
    the one that theory has with the scene's f and the same range of U, where it slides too. Finite
    elements are left out, which is stated where `against` is "fe".

    # notation: f coefficient of friction, U relative tangential displacement
    """
    sliding_loops = {"theory, best f": fitted_loop}
    # None where the range of U is too short for a slide with this f
    loop_of_scene = fitted_loop.gross_loop_with_friction(scene.friction.coefficient)
    if loop_of_scene is not None:
        sliding_loops[f"theory, {WITH_SCENE_FRICTION}"] = loop_of_scene
    middle_load = float(measured_loop.load.max() + measured_loop.load.min()) / 2
    loops = []
    for name, sliding_loop in sliding_loops.items():
        # from the middle of the loop, at shares of the cycle from 0 to 1
        computed_displacement, load_from_middle = sliding_loop.closed_curve(SHARES_OF_CYCLE)
        # the origin of U is arbitrary: the mean of the computed U becomes that of the measured one
        displacement_at_rows = np.interp(fit.share_of_cycle, SHARES_OF_CYCLE, computed_displacement)
        computed_displacement = computed_displacement + float(
            np.mean(measured_loop.displacement - displacement_at_rows)
        )
        # dU/dQ of the computed loop [1/stress], and its root mean square distance along U from the
        # means of the measured rows [length]
        slope, distance = _slope_and_distance(
            measured_loop, fit.share_of_cycle, computed_displacement, load_from_middle
        )
        table_row = LoopRow(
            name,
            sliding_loop.friction,
            sliding_loop.area,
            area_uncertainty=0.0,
            slope=slope,
            distance=distance,
        )
        loops.append(
            _ComputedLoop(table_row, computed_displacement, load_from_middle + middle_load)
        )
    sentences = []
    if against == "fe":
        sentences.append(
            "Finite elements are left out: under given P and Q they can't slide as a whole"
        )
    return _ComputedLoops(loops, sentences)


def _slope_and_distance(
    measured_loop: MeasuredLoop,
    share_of_cycle: Array,
    computed_displacement: Array,
    computed_load: Array,
) -> tuple[float, float]:
    """Slope dU/dQ of a computed loop, and the root mean square of its distances from the means of
    the rows, along U.

    Parameters
    ----------
    measured_loop
        the measured rows
    share_of_cycle
        (n_rows,) share of the cycle that is over at each row
    computed_displacement, computed_load
        (n_instants,) U and Q of the computed loop at `SHARES_OF_CYCLE` of the cycle

    # notation: Q tangential load, U relative tangential displacement
    """
    displacement_at_rows = np.interp(share_of_cycle, SHARES_OF_CYCLE, computed_displacement)
    slope = _slope_of_line(
        displacement_at_rows, np.interp(share_of_cycle, SHARES_OF_CYCLE, computed_load)
    )
    _, distances = means_of_parts(share_of_cycle, measured_loop.displacement - displacement_at_rows)
    return slope, math.sqrt(float(np.mean(distances**2)))


def _slope_of_line(displacement: Array, load: Array) -> float:
    """Slope dU/dQ of the straight line through the rows of a loop, (n,) each [1/stress]."""
    load_from_mean = load - load.mean()
    return float(load_from_mean @ displacement / (load_from_mean @ load_from_mean))


def means_of_parts(share_of_cycle: Array, *row_values: Array) -> tuple[Array, ...]:
    """Means of values of the rows of a measured loop in equal parts of the cycle: the number of
    rows in each of the k parts that have any, then the mean of each of `row_values` (n,) there,
    (k,) each. `share_of_cycle` (n,) is the share of the cycle that is over at each row.

    A part has eight rows on average, but there are 20 parts at least and 200 at most.
    """
    n_parts = max(20, min(_MOST_PARTS_OF_CYCLE, len(share_of_cycle) // 8))
    part_of_row = np.floor(share_of_cycle * n_parts).astype(int)
    row_counts = np.bincount(part_of_row)
    has_rows = row_counts > 0
    means = [
        np.bincount(part_of_row, values)[has_rows] / row_counts[has_rows] for values in row_values
    ]
    return (row_counts[has_rows].astype(float), *means)
