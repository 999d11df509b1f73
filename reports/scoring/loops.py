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
from typing import Literal

import numpy as np

from reports.scoring.loop_area import LoopArea, area_about_fit, polygon_area
from reports.scoring.loop_fitted import FittedLoop, against_rows
from reports.scoring.loop_masing import MasingLoop
from reports.scoring.loop_over_time import fit_over_time
from reports.scoring.loop_rows import MeasuredLoop, read_loop
from reports.scoring.loop_steady_rows import fit_steady_rows
from reports.scoring.loop_theory import (
    SHARES,
    cycle_loads,
    finite_element_shift,
    has_two_branches,
    least_friction,
    theory_shift,
)
from scenes import InputError, Scene
from scenes.array_types import Array
from scenes.measured import ReadAs

__all__ = [
    "OF_SCENE",
    "SHARES",
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
OF_SCENE = "the scene's f"
"""Which f a computed loop has, in the name of its row."""

# Parts of the cycle in which rows are averaged for the figures.
_PARTS = 200


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


@dataclass(frozen=True, eq=False)
class LoopScore:
    """What a measured loop says.

    Attributes
    ----------
    friction, low, high
        f that fits best and its 95 % interval; high None where no larger f can be told from it
    compliance, compliance_fitted
        of the rig [1/stress]
    scale
        r, the file's Q over the scene's
    cycles
        how many the rows cover
    noise
        rms of U about the best fit [length]
    rows
        measured, then each computed loop
    read_as
        how the file was read
    said
        what was assumed
    tau, shift, load, curves
        the rows on the cycle [share], and each computed loop (U with the rig, Q), for the
        figure
    """

    scene: Scene
    source: str
    friction: float
    low: float
    high: float | None
    compliance: float
    compliance_fitted: bool
    scale: float
    cycles: float
    noise: float
    rows: tuple[LoopRow, ...]
    read_as: ReadAs
    said: tuple[str, ...]
    tau: Array
    shift: Array
    load: Array
    curves: tuple[tuple[str, Array, Array], ...]

    @property
    def agrees(self) -> bool:
        """Whether the scene's own f lies in the interval."""
        return (
            self.low
            <= self.scene.friction.coefficient
            <= (math.inf if self.high is None else self.high)
        )

    @property
    def sentence(self) -> str:
        """The finding."""
        ends = (
            [self.low, self.friction] if self.high is None else [self.low, self.friction, self.high]
        )
        # As many digits as tell the ends of the interval from its middle.
        digits = next(
            (
                count
                for count in range(4, 16)
                if len({f"{end:.{count}g}" for end in ends}) == len(set(ends))
            ),
            16,
        )
        high = "no upper limit" if self.high is None else f"{self.high:.{digits}g}"
        lies = "lies within" if self.agrees else "lies outside"
        return (
            f"The loop is best fitted by f = {self.friction:.{digits}g} (95 %:"
            f" {self.low:.{digits}g} to {high}); the scene's f ="
            f" {self.scene.friction.coefficient:.{max(digits, 4)}g} {lies} this interval."
        )


def require_loop(scene: Scene) -> None:
    """InputError for a scene that no measured loop can be scored against."""
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
    """The f that fits a measured loop best, its interval, and the loops of the engines beside it.

    Parameters
    ----------
    rig_compliance
        C [1/stress], beyond the datum length of the profile; fitted if None
    against
        "fe" has the finite elements solve the scene with its own f and with the best one too

    Raises
    ------
    InputError
        For a scene whose loads do not repeat or have no Q, for rows that cover less than a cycle or
        do not follow its Q.

    Examples
    --------
    >>> import semi_analytic
    >>> from scenes import load_scene
    >>> scene = load_scene("cattaneo-mindlin")  # f = 0.5
    >>> path, share = scene.load.path(), np.arange(200) / 100
    >>> times = path.cycle_start + path.period * (1 + np.arange(101) / 100)
    >>> exact = semi_analytic.solve(scene, x=0.0, time=times, fields="tangential_displacement")
    >>> row = np.arange(200) % 100
    >>> rig = exact.tangential_displacement + 1e-5 * exact.tangential_load
    >>> found = score_loop(MeasuredLoop("rig", rig[row], exact.tangential_load[row], share), scene)
    >>> round(found.friction, 3), round(found.compliance, 7)
    (0.5, 1e-05)
    """
    require_loop(scene)
    for name, values in (("U", loop.shift), ("Q", loop.load)):
        if not np.ptp(values) > 0:
            raise InputError(f"{loop.source}: {name} is the same in every row: there is no loop")
    if has_two_branches(scene):
        loop, fit = fit_steady_rows(loop, scene, rig_compliance)
    else:
        fit = fit_over_time(loop, scene, rig_compliance)
    scale = fit.scale
    share = fit.share
    least = least_friction(scene)
    tangential = cycle_loads(scene)[1]
    load_of_cycle = scale * tangential
    said = list(fit.said)
    area = _area(loop, fit)
    slope_of_rows = _slope(loop.shift, np.interp(share, SHARES, load_of_cycle))
    rows = [
        LoopRow(
            "measured",
            None,
            area.value,
            area.uncertainty,
            slope_of_rows,
            math.nan,
            area.by_distance,
            area.by_noise,
        ),
    ]
    way = "the area of the polygon of the rows"
    if fit.model is not None:
        way = "the area of the best fit, with what the rows enclose beside it,"
    said.append(
        f"W as measured is {way} over {area.cycles} {'cycle' if area.cycles == 1 else 'cycles'}:"
        f" ± {area.by_distance:.2g} by what lies between rows,"
        f" ± {area.by_noise:.2g} by their scatter (95 %)"
    )
    curves: list[tuple[str, Array, Array]] = []

    def add(name: str, coefficient: float, shift: Array) -> None:
        """A computed loop, U (n_instants,) of theory or finite elements at the scene's loads."""
        _, compliance, origin = against_rows(
            loop, shift, share, load_of_cycle, scale, rig_compliance
        )
        with_rig = scale * shift + compliance * load_of_cycle + origin
        work = scale**2 * float(np.sum((tangential[1:] + tangential[:-1]) / 2 * np.diff(shift)))
        slope, distance = _beside_rows(loop, share, with_rig, load_of_cycle)
        rows.append(LoopRow(name, coefficient, work, 0.0, slope, distance))
        curves.append((name, with_rig, load_of_cycle + fit.offset))

    cases = {"best f": fit.friction / scale, OF_SCENE: scene.friction.coefficient / scale}
    if fit.gross and fit.model is not None:
        cases = {}
        for name, slid in _sliding_loops(fit.model, scene.friction.coefficient).items():
            shift, loads = slid.closed(SHARES)
            shift = shift + float(np.mean(loop.shift - np.interp(share, SHARES, shift)))
            slope, distance = _beside_rows(loop, share, shift, loads)
            rows.append(LoopRow(name, slid.friction, slid.area, 0.0, slope, distance))
            middle = float(loop.load.max() + loop.load.min()) / 2
            curves.append((name, shift, loads + middle))
        if against == "fe":
            said.append(
                "Finite elements are left out: under given P and Q they can't slide as a whole"
            )
    for name, coefficient in cases.items():
        if coefficient < least:
            said.append(
                f"With {name}, {scale * coefficient:.4g}, the measured loads slide grossly: there"
                " is no such loop"
            )
            continue
        add(f"theory, {name}", scale * coefficient, theory_shift(fit.scene, coefficient))
        if against == "fe":
            add(
                f"finite elements, {name}",
                scale * coefficient,
                finite_element_shift(fit.scene, coefficient),
            )
    return LoopScore(
        scene=fit.scene,
        source=loop.source,
        friction=fit.friction,
        low=fit.low,
        high=fit.high,
        compliance=fit.compliance,
        compliance_fitted=rig_compliance is None,
        scale=scale,
        cycles=fit.cycles,
        noise=fit.shift_noise,
        rows=tuple(rows),
        read_as=loop.read_as,
        said=tuple(said),
        tau=share,
        shift=loop.shift,
        load=loop.load,
        curves=tuple(curves),
    )


def _beside_rows(
    loop: MeasuredLoop, share: Array, shift: Array, load: Array
) -> tuple[float, float]:
    """Slope of a computed loop, U and Q at the shares of a cycle of the engines, and the root mean
    square of its distances from the rows along U; `share` (n_rows,) places the rows on it.
    """
    shift_at_rows = np.interp(share, SHARES, shift)
    slope = _slope(shift_at_rows, np.interp(share, SHARES, load))
    _, distances = means_of_parts(share, loop.shift - shift_at_rows)
    return slope, math.sqrt(float(np.mean(distances**2)))


def _area(loop: MeasuredLoop, fit: FittedLoop) -> LoopArea:
    """W of the rows: about the fitted loop, and where there is none, of the polygon of the rows."""
    if fit.model is None or fit.masing is None:
        return polygon_area(loop.shift, loop.load, fit.phase, fit.shift_noise, fit.load_noise)
    return area_about_fit(fit.model, fit.masing, float(fit.phase[-1] - fit.phase[0]))


def _sliding_loops(fitted: MasingLoop, friction_of_scene: float) -> dict[str, MasingLoop]:
    """The fitted loop, and that of the scene's f with the same range of U, where it slides too."""
    loops = {"theory, best f": fitted}
    other = fitted.with_friction(friction_of_scene)
    if other is not None:
        loops[f"theory, {OF_SCENE}"] = other
    return loops


def _slope(shift: Array, load: Array) -> float:
    """dU/dQ of the straight line through a loop."""
    apart = load - load.mean()
    return float(apart @ shift / (apart @ apart))


def means_of_parts(share: Array, *values: Array) -> tuple[Array, ...]:
    """Rows in each part of the cycle that has any, and the mean of each of `values` (n,) there:
    (k,) each.
    """
    parts = np.floor(share * max(20, min(_PARTS, len(share) // 8))).astype(int)
    count = np.bincount(parts)
    some = count > 0
    return (
        count[some].astype(float),
        *(np.bincount(parts, one)[some] / count[some] for one in values),
    )
