"""A measured loop of Q over the relative displacement U as the reference: which f fits it, and how
theory and finite elements lie.

# notation: A = 2/E*, C compliance of the rig, f friction coefficient, W area of the loop, tau time
#           on the scene's cycle, r factor of the file's Q over the scene's

A rig measures U beside the loads, and in it its own elastic compliance:

    U = r U(tau; f/r) + C Q + U0 + noise,   Q = r Q(tau) + Q0 + noise

where U(tau; f) is that of the steady cycle of the scene. Loads that are r times as large with the
same f slip as those of the scene with f/r. U of half-planes hangs on a datum length by a term that
is linear in Q at constant P: a fitted C takes it in, a given one is that of the rig beyond
`profile.datum_length`.

Where Q has one highest and one lowest value in a cycle, nothing depends on the form of Q or U over
time. Rows have a branch by their order (`loop_branches`), and lie on it where theory's loop is
nearest: at constant P that of Masing's rule, which may slide as a whole at its ends
(`loop_masing`); else that of the scene, with P over Q as there (`loop_fit`).
Where Q has more turning points in a cycle, tau follows from the order of the rows, or from their
times: period and phase are those with which Q fits the scene's best. Then C and U0 are found by
linear least squares, f by a scan and a bounded search on the sum of squares, and its interval is
where that sum exceeds the least one by what chance gives in 95 %.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.checking import nearest_to_sliding
from reports.scoring.loop_branches import Branches, LoopArea, find_branches, polygon_area, row_noise
from reports.scoring.loop_fit import (
    LoopRows,
    LoopsOverFriction,
    Weights,
    fit_loop,
)
from reports.scoring.loop_masing import (
    BestLoop,
    MasingFit,
    MasingLoop,
    MeasuredRows,
    MemoryCurve,
    best_loop,
    memory_curve,
    with_interval,
)
from reports.scoring.loop_steadiness import (
    Misfit,
    differences_of_cycles,
    drift_of_shift,
)
from reports.scoring.mapping import Mapping, converted, find_column, listed
from reports.units import load_unit, units
from scenes import InputError, Scene
from scenes.array_types import Array
from scenes.column_names import ALIASES, plain
from scenes.measured import ReadAs, layout_in_words, unit_of_column
from scenes.text_tables import TableKind, TextTable, text_table

Against = Literal["exact", "fe"]
OF_SCENE = "the scene's f"
"""Which f a computed loop has, in the name of its row."""

_SHIFT_NAMES = (
    "U",
    "u",
    "displacement",
    "relative displacement",
    "tangential displacement",
    "shift",
    "slip",
    "U1",
)
_BY_NUMBER = "columns.slip = 1 and columns.tangential_load = 2 of a mapping"
# Rows that show with how many digits numbers are written.
_DIGITS_SEEN = 1000
_FEWEST = 20
_LEAST_CYCLES = 0.9
_MOST_CYCLES = 2000
# Parts of the cycle in which rows are averaged for the figures.
_PARTS = 200
# Instants of a cycle at which theory is evaluated, straight between: an error of 1e-5 of the range
# of U.
_INSTANTS = 721
# Coefficients that are scanned, from gross sliding to so many times as much; beyond, a loop is a
# line.
_SCANNED = 60
_WIDEST = 40.0
# Error of a fitted f by theory at so many instants, straight between, of itself; and by samples of
# the memory curve.
_OF_THEORY = 1e-5
_OF_MEMORY = 1e-6
# Rows that do not follow the scene's Q better than this share of its amplitude are another
# experiment's.
_FOLLOWS = 0.15
# Part of the distances that is no scatter, over the mean opening of the loop in U, from which rows
# under a varying P are said not to be examined, and beyond which they are of no loop of theory.
_STEADY = 0.02
_OF_THEORY_AT_ALL = 0.015
# Theory's own error of a loop is below this share of its opening.
_WORTH_SAYING = 1e-3
# U that moves on by more than this share of its range in a cycle is no drift of a gauge.
_DRIFT = 0.03
# A drift below this share of the range of U is not worth a word.
_DRIFT_SAID = 1e-3
# Rows are left out as a run-in where the rest fits so much better than all.
_BETTER = 0.5
# Cycles that are left without a run-in, at least: fewer do not show whether they are alike.
_FEWEST_ALIKE = 2.4
# Half cycles of a run-in, at most, and never more than half of all.
_RUN_IN = 4
# Chance gives so much of the sum of squares over its mean in 95 %: chi squared of one degree.
_CHI = 3.841


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """Rows of a rig: `shift` U and `load` Q, (n,) in the units of the scene, `time` (n,) in any.

    `read_as` is how the file was read: each column with its heading, unit and factor. `resolution`
    is the step of U and of Q that the digits of the rows resolve, 0 where they hold every digit.
    """

    source: str
    shift: Array
    load: Array
    time: Array
    read_as: ReadAs = ()
    resolution: tuple[float, float] = (0.0, 0.0)


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


def read_loop(path: Path, mapping: Mapping, scene: Scene) -> MeasuredLoop:
    """The columns U and Q of a table, and its time if there is one.

    Raises
    ------
    InputError
        As the reader of tables; for a column that is missing or in a unit that can't be turned into
        the scene's, for too few rows.
    """
    table = text_table(
        path,
        kind=TableKind(
            is_known=_is_of_loops,
            example="U,Q",
            keys_by_number=_BY_NUMBER,
            numbered=_is_numbered(mapping),
        ),
    )
    names = table.names
    where = str(path)
    alone = not table.head and len(names) == 2  # the other of two columns without names
    force = find_column(mapping, "tangential_load", names, where, needed=not alone)
    stated = (
        find_column(mapping, "slip", names, where) if mapping.columns.slip is not None else None
    )
    if alone and force is None and stated is not None:
        force = names[1 - names.index(stated)]
    shifts = [name for alias in _SHIFT_NAMES for name in names if plain(name) == plain(alias)]
    shift = stated or next(iter(dict.fromkeys(shifts)), None)
    if alone and shift is None and force is not None:
        shift = names[1 - names.index(force)]
    if shift is None or force is None:
        raise InputError(
            f"{where}: no column for the relative displacement (looked for"
            f" {', '.join(_SHIFT_NAMES[:4])} ...) among {listed(names)}; name it by columns.slip of"
            " a mapping"
        )
    if shift == force:
        raise InputError(
            f"{where}: the mapping takes {shift!r} for U and for Q; state columns.slip and"
            " columns.tangential_load"
        )
    time = find_column(mapping, "time", names, where)
    count = len(table.values)
    if count < _FEWEST:
        raise InputError(
            f"{where}: {count} rows are too few for a loop: at least {_FEWEST} are needed"
        )
    shifts_read = _column_of_loop(where, table, mapping, scene, shift, "slip")
    loads_read = _column_of_loop(where, table, mapping, scene, force, "tangential_load")
    for column in (shifts_read, loads_read):
        if not np.ptp(column.values) > 0:
            raise InputError(f"{where}: {column.name} is the same in every row: there is no loop")
    instants = np.arange(count, dtype=float)
    time_in_words = "no column: rows follow each other evenly"
    if time is not None:
        instants = table.column(time)
        time_in_words = f"{time!r}, as it stands: no result depends on its unit"
    back = np.flatnonzero(np.diff(instants) <= 0)
    if len(back):
        k = int(back[0]) + 1
        raise InputError(
            f"{where}, line {table.lines[k]}: {time} = {instants[k]:.6g} does not ascend: rows"
            " stand in the order of time"
        )
    read_as = layout_in_words(path, table)
    read_as.append(("relative displacement U", shifts_read.words))
    read_as.append(("tangential load Q", loads_read.words))
    read_as.append(("time", time_in_words))
    return MeasuredLoop(
        source=where,
        shift=shifts_read.values,
        load=loads_read.values,
        time=instants - instants[0],
        read_as=tuple(read_as),
        resolution=(shifts_read.step, loads_read.step),
    )


class _ColumnOfLoop(NamedTuple):
    """A column by its name in the file: `values` (n,) and the `step` of its last digit, both in the
    unit of the scene; how it was read, in words.
    """

    name: str
    values: Array
    step: float
    words: str


def _column_of_loop(
    where: str,
    table: TextTable,
    mapping: Mapping,
    scene: Scene,
    name: str,
    quantity: Literal["slip", "tangential_load"],
) -> _ColumnOfLoop:
    """U or Q of a table in the unit of the scene.

    Raises
    ------
    InputError
        For a unit that is not understood, for forces without a thickness, and for forces per length
        with one.
    """
    kind: Literal["length", "load"] = "length" if quantity == "slip" else "load"
    unit_of_scene = units(scene)[1] if kind == "length" else load_unit(scene)
    number = table.names.index(name)
    thickness_stated = kind == "load" and "thickness" in mapping.model_fields_set
    factor_stated = getattr(mapping.factors, kind)
    unit_factor = 1.0
    words = [repr(name)]
    if factor_stated is not None:
        words.append(f"times {factor_stated:.9g} (factors.{kind} of the mapping)")
    else:
        unit = unit_of_column(table, number, kind, scene.units)
        if unit.word == unit_of_scene:  # whatever words the scene has for its units
            in_words = f"{unit.word} (in its heading), times 1"
            unit = replace(unit, factor=1.0, per_length=kind == "load", fault="", words=in_words)
        if thickness_stated and "/" in unit.word:
            raise InputError(
                f"{where}: the column {name!r} is in {unit.word}, a force per length, and the"
                " mapping states a thickness, by which forces are divided: take thickness out of"
                " the mapping, or state factors.load"
            )
        force_alone = kind == "load" and unit.known and not unit.per_length
        if unit.fault or (force_alone and not thickness_stated):
            or_thickness = ""
            if force_alone:
                or_thickness = ", or the thickness of the contact, by which it is divided"
            raise InputError(
                f"{where}: the column {name!r} is in {unit.word}, and the scene in"
                f" {unit_of_scene}: state factors.{kind} in a mapping, by which it is"
                f" multiplied{or_thickness}"
            )
        unit_factor = unit.factor
        words.append(unit.words)
    if thickness_stated:
        words.append(f"over the thickness {mapping.thickness:.9g}")
    if mapping.sign(quantity) < 0:
        words.append("sign turned")
    step = unit_factor * np.array([_step_of_digits(table.values[:, number])])
    return _ColumnOfLoop(
        name=name,
        values=converted(mapping, quantity, unit_factor * table.values[:, number]),
        step=abs(float(converted(mapping, quantity, step)[0])),
        words=", ".join(words),
    )


def _is_of_loops(heading: str) -> bool:
    """Whether a heading is one that a loop's table may have."""
    known = (*_SHIFT_NAMES, *ALIASES["tangential_load"], *ALIASES["time"])
    return plain(heading) in {plain(alias) for alias in known}


def _is_numbered(mapping: Mapping) -> bool:
    """Whether the mapping takes U or Q by the number of its column."""
    return isinstance(mapping.columns.slip, int) or isinstance(mapping.columns.tangential_load, int)


def _step_of_digits(values: Array) -> float:
    """The step of the last digit that rows (n,) are written with; of most of them, since zeros at
    the end do not show.

    >>> (
    ...     _step_of_digits(np.array([0.25, 0.3, -0.17])),
    ...     _step_of_digits(np.array([12.0, 1500.0, 7.0])),
    ... )
    (0.01, 1.0)
    """
    places = [
        int(Decimal(repr(value)).normalize().as_tuple().exponent)
        for value in values[:_DIGITS_SEEN].tolist()
    ]
    return float(10.0 ** int(np.floor(np.median(places)))) if places else 0.0


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
    if _has_two_branches(scene):
        loop, fit = _steady_part(loop, scene, rig_compliance)
    else:
        fit = _fit_over_time(loop, scene, rig_compliance)
    scale = fit.scale
    share = fit.share
    least = _least_friction(scene)
    tangential = _cycle_loads(scene)[1]
    load_of_cycle = scale * tangential
    said = list(fit.said)
    measure = polygon_area if fit.model is None else _area_of_last_cycles
    area = measure(loop.shift, loop.load, fit.phase, fit.shift_noise, fit.load_noise)
    if fit.model is not None and fit.place is not None:
        area = _with_theory_between_rows(area, fit.model, fit.place, fit.phase)
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
    said.append(
        f"W as measured is the area of the polygon of the rows over {area.cycles}"
        f" {'cycle' if area.cycles == 1 else 'cycles'}"
        f"{'' if fit.model is None else ', and of the best fit between them'}:"
        f" ± {area.by_distance:.2g} by what lies between rows,"
        f" ± {area.by_noise:.2g} by their scatter (95 %)"
    )
    curves: list[tuple[str, Array, Array]] = []

    def add(name: str, coefficient: float, shift: Array) -> None:
        """A computed loop, U (n_instants,) of theory or finite elements at the scene's loads."""
        _, compliance, origin = _against_rows(
            loop, shift, share, load_of_cycle, scale, rig_compliance
        )
        with_rig = scale * shift + compliance * load_of_cycle + origin
        work = scale**2 * float(np.sum((tangential[1:] + tangential[:-1]) / 2 * np.diff(shift)))
        shift_at_rows = np.interp(share, SHARES, with_rig)
        _, rest = means_of_parts(share, loop.shift - shift_at_rows)
        slope = _slope(shift_at_rows, np.interp(share, SHARES, load_of_cycle))
        rows.append(
            LoopRow(name, coefficient, work, 0.0, slope, math.sqrt(float(np.mean(rest**2))))
        )
        curves.append((name, with_rig, load_of_cycle + fit.offset))

    cases = {"best f": fit.friction / scale, OF_SCENE: scene.friction.coefficient / scale}
    if fit.gross and fit.model is not None:
        cases = {}
        for name, slid in _sliding_loops(fit.model, scene.friction.coefficient).items():
            shift, loads = slid.closed(SHARES)
            center = float(np.mean(loop.shift - np.interp(share, SHARES, shift)))
            slope = _slope(np.interp(share, SHARES, shift), np.interp(share, SHARES, loads))
            _, rest = means_of_parts(share, loop.shift - np.interp(share, SHARES, shift) - center)
            rows.append(
                LoopRow(
                    name, slid.friction, slid.area, 0.0, slope, math.sqrt(float(np.mean(rest**2)))
                )
            )
            middle = float(loop.load.max() + loop.load.min()) / 2
            curves.append((name, shift + center, loads + middle))
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
        add(f"theory, {name}", scale * coefficient, _theory(fit.scene, coefficient))
        if against == "fe":
            add(
                f"finite elements, {name}",
                scale * coefficient,
                _finite_elements(fit.scene, coefficient),
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


# ----------------------------------------------------------------------------------------- the fits
_NO_MISFIT = Misfit(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class _Fit:
    """f with its interval, the rig, and where the rows lie.

    share, phase : (n,) place on the scene's cycle; cycles since any instant
    scale, offset : r and Q0 of the file
    shift_noise, load_noise : sigma of U and of Q
    misfit : what the distances show; nothing where rows are placed over time
    model, place : the fitted loop, and where the rows lie on it; None where P varies
    gross : whether it slides as a whole at its ends
    """

    scene: Scene
    friction: float
    low: float
    high: float | None
    compliance: float
    share: Array
    phase: Array
    cycles: float
    scale: float
    offset: float
    shift_noise: float
    load_noise: float
    said: tuple[str, ...]
    misfit: Misfit = _NO_MISFIT
    model: MasingLoop | None = None
    place: Array | None = None
    gross: bool = False


def _area_of_last_cycles(
    shift: Array, load: Array, phase: Array, shift_noise: float, load_noise: float
) -> LoopArea:
    """The area of the polygon of rows (n,) over the last whole cycles: a run-in stands first."""
    backwards = polygon_area(shift[::-1], load[::-1], -phase[::-1], shift_noise, load_noise)
    return replace(backwards, value=-backwards.value)


def _with_theory_between_rows(
    area: LoopArea, model: MasingLoop, place: Array, phase: Array
) -> LoopArea:
    """The area of the polygon, and what the fitted loop has outside the chords between the rows'
    places on it; a third of that is stated as its uncertainty.
    """
    on_loop = model.at_rows(place)
    polygon = _area_of_last_cycles(*on_loop, phase, 0.0, 0.0)
    between = model.area - polygon.value
    return replace(area, value=area.value + between, by_distance=abs(between) / 3)


def _sliding_loops(fitted: MasingLoop, friction_of_scene: float) -> dict[str, MasingLoop]:
    """The fitted loop, and that of the scene's f with the same range of U, where it slides too."""
    loops = {"theory, best f": fitted}
    other = fitted.with_friction(friction_of_scene)
    if other is not None:
        loops[f"theory, {OF_SCENE}"] = other
    return loops


def _least_friction(scene: Scene) -> float:
    """f of gross sliding at the scene's loads."""
    return nearest_to_sliding(scene).ratio * scene.friction.coefficient * (1 + 1e-9)


def _has_two_branches(scene: Scene) -> bool:
    """Whether Q has one highest and one lowest value in a cycle, and no other turning point."""
    tangential = _cycle_loads(scene)[1]
    steps = np.diff(tangential)
    signs = np.sign(steps[np.abs(steps) > 1e-9 * np.ptp(tangential)])
    return bool(len(signs) > 0 and np.count_nonzero(signs[1:] != signs[:-1]) <= 2)


def _has_constant_normal_load(scene: Scene) -> bool:
    normal = _cycle_loads(scene)[0]
    return bool(np.ptp(normal) <= 1e-9 * normal.max())


def _said_of_scale(scale: float) -> list[str]:
    if abs(scale - 1) <= 1e-3:
        return []
    return [
        f"Q of the file is {scale:.4g} times that of the scene: loads as in the file were taken, P"
        " as in the scene"
    ]


def _steady_part(
    loop: MeasuredLoop, scene: Scene, rig_compliance: float | None
) -> tuple[MeasuredLoop, _Fit]:
    """The rows that are of one steady loop, without the drift of their U, and their fit.

    Raises
    ------
    InputError
        Where the rows are of no steady loop of theory.
    """
    if not _has_constant_normal_load(scene):
        # Distances from the nearest point of a loop are no scatter beside its turning points: three
        # of twenty good loops with noise were refused by them.
        fit = _fit_where_load_varies(loop, scene, rig_compliance)
        share = _share_of_opening(loop, fit.misfit, fit.phase)
        sentence = "P varies: the rows were not examined for drift, run-in and cycles that differ"
        if share > _STEADY or _cycles_differ(loop):
            fit = replace(fit, said=(*fit.said, sentence))
        return loop, _with_widening_said(fit, share)

    drift = _drift_of_cycle(loop)
    if drift:
        raise InputError(
            f"{loop.source}: its rows are of no steady loop: U moves on by {100 * drift:+.2g} % of"
            " its range in each cycle, so the contact slides on or the gauge does; give the rows of"
            " cycles that are alike"
        )
    curve = memory_curve(scene, _least_friction(scene) / float(np.ptp(_cycle_loads(scene)[1])))
    candidates = []
    for part, sentence in _without_run_in(loop):
        if _cycles_differ(part):
            continue
        branches = _branches_of_both(part)
        rows = MeasuredRows(
            part.shift, part.load, part.time, branches, rig_compliance, part.resolution
        )
        best = best_loop(rows, curve)
        share = _share_of_opening(part, best.misfit, branches.phase)
        candidates.append(_Candidate(share, part, branches, best, sentence))
        if not best.first_differs and share < _OF_THEORY:
            break
    if not candidates:
        raise InputError(
            f"{loop.source}: its rows are of no steady loop: {_cycles_differ(loop)}; give the rows"
            " of cycles that are alike"
        )
    chosen = min(candidates, key=lambda candidate: (candidate.share, len(candidate.said)))
    whole = candidates[0]
    if chosen.share > _BETTER * whole.share and not whole.best.first_differs:
        chosen = whole
    if chosen.share > _OF_THEORY_AT_ALL and rig_compliance is None:
        reason = _cycles_differ(loop) or (
            "its cycles are alike, but their form is not that of theory (other bodies, plastic"
            " flow, wear, or noise that is no scatter)"
        )
        raise InputError(
            f"{loop.source}: its rows are of no steady loop of {scene.name}: {reason}; the best fit"
            f" is {100 * chosen.share:.2g} % of the loop's opening away from rows that lie beside"
            f" each other (limit {100 * _OF_THEORY_AT_ALL:.2g} %)"
        )
    part, fit = _fit_at_constant_load(chosen, scene, curve)
    if chosen.share > _OF_THEORY_AT_ALL:
        sentence = (
            f"With the stated rig compliance the best fit is {100 * chosen.share:.2g} % of the"
            " loop's opening away from rows that lie beside each other: leave it out, and it is"
            " fitted"
        )
        fit = replace(fit, said=(*fit.said, sentence))
    return part, _with_widening_said(fit, chosen.share)


class _Candidate(NamedTuple):
    """Rows without a run-in, and what fits them: share of the loop's opening that is no scatter;
    what was left out, in words.
    """

    share: float
    part: MeasuredLoop
    branches: Branches
    best: BestLoop
    said: str


def _branches_of_both(loop: MeasuredLoop) -> Branches:
    """Branches of the rows by U and Q together, each over its range: their sum has its turning
    points where the branches have theirs, also where Q stays while the contact slides.
    """
    range_of_shift = float(np.ptp(loop.shift))
    range_of_load = float(np.ptp(loop.load))
    both = loop.shift / range_of_shift + loop.load / range_of_load
    step = loop.resolution[0] / range_of_shift + loop.resolution[1] / range_of_load
    return find_branches(loop.shift, both, loop.time, step, loop.source)


def _fit_at_constant_load(
    chosen: _Candidate, scene: Scene, curve: MemoryCurve
) -> tuple[MeasuredLoop, _Fit]:
    """The chosen rows without their drift, and their fit with its interval."""
    loop = chosen.part
    branches = chosen.branches
    fit = with_interval(chosen.best, _OF_MEMORY)
    passed = (loop.time - loop.time[0]) / loop.time[-1]
    straight = replace(loop, shift=loop.shift - fit.drift * (passed - passed[-1] / 2))
    tangential = _cycle_loads(scene)[1]
    scale = (fit.highest - fit.lowest) / float(np.ptp(tangential))
    said = [
        (
            f"The rows cover {branches.cycles:.4g} cycles between Q = {fit.lowest:.6g} and"
            f" {fit.highest:.6g}; P is constant, so that the form of Q and U over time counts for"
            " nothing"
        ),
        *_said_of_scale(scale),
    ]
    if chosen.said:
        said.append(chosen.said)
    range_of_shift = float(np.ptp(loop.shift))
    error = 1.96 * fit.drift_error
    if abs(fit.drift) > max(error, _DRIFT_SAID * range_of_shift):
        said.append(
            f"U drifts by {100 * fit.drift / range_of_shift / branches.cycles:+.2g} % of its range"
            " in a cycle: taken out"
        )
    if fit.gross:
        said.append(
            f"The contact slides as a whole by {fit.slide:.3g} {units(scene)[1]} at each end of the"
            f" loop: f is Q/P there, with Q = {(fit.highest - fit.lowest) / 2:.6g} from the middle"
        )
    if fit.gross:
        share = np.mod(fit.distances.place / 2 + 0.5, 1.0)
    else:
        share = _share_by_load(loop.load, fit.distances.place < 1, fit, tangential)
    return straight, _Fit(
        scene=scene,
        friction=fit.friction,
        low=fit.low,
        high=fit.high,
        compliance=fit.compliance,
        share=share,
        phase=branches.phase,
        cycles=branches.cycles,
        scale=scale,
        offset=fit.lowest - scale * float(tangential.min()),
        shift_noise=fit.weights.shift,
        load_noise=fit.weights.load,
        said=tuple(said),
        misfit=fit.misfit,
        model=MasingLoop(curve, fit.values),
        place=fit.distances.place,
        gross=fit.gross,
    )


def _share_of_opening(loop: MeasuredLoop, misfit: Misfit, phase: Array) -> float:
    """The part of the distances that is no scatter over the mean opening of the loop in U."""
    area = polygon_area(loop.shift, loop.load, phase, 0.0, 0.0).value
    return misfit.systematic * float(np.ptp(loop.load)) / max(abs(area), 1e-300)


def _cycles_differ(loop: MeasuredLoop) -> str:
    """How the cycles differ, in words; "" where they do not."""
    noise = max(row_noise(loop.load), loop.resolution[1] / math.sqrt(12))
    return differences_of_cycles(loop.shift, loop.load, loop.time, noise)


def _with_widening_said(fit: _Fit, share: float) -> _Fit:
    if fit.misfit.widening == 1.0 or share < _WORTH_SAYING:
        return fit
    sentence = (
        f"Neighbouring rows lie on the same side of the best fit (correlation"
        f" {fit.misfit.correlation:.2g}), by {100 * share:.2g} % of the loop's opening: the"
        f" interval of f is {fit.misfit.widening:.2g} times as wide for it"
    )
    return replace(fit, said=(*fit.said, sentence))


def _without_run_in(loop: MeasuredLoop) -> Iterator[tuple[MeasuredLoop, str]]:
    """The loop, and the loop without its first half cycles; each with what was done."""
    yield loop, ""
    phase = _branches_of_both(loop).phase
    cycles = float(phase[-1] - phase[0])
    for half_cycles in range(1, min(_RUN_IN, int(cycles)) + 1):
        first = int(np.argmax(phase >= phase[0] + half_cycles / 2))
        rest = replace(
            loop, shift=loop.shift[first:], load=loop.load[first:], time=loop.time[first:]
        )
        if phase[-1] - phase[first] < _FEWEST_ALIKE:
            return
        yield rest, f"Rows 1 to {first} are left out: run-in, unlike the later cycles"


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


def _fit_where_load_varies(loop: MeasuredLoop, scene: Scene, rig_compliance: float | None) -> _Fit:
    """Where P varies and Q has two branches in a cycle: by turning points of Q, and theory between
    them.
    """
    branches = find_branches(loop.shift, loop.load, loop.time, loop.resolution[1], loop.source)
    rows = LoopRows(loop.shift, loop.load, branches, rig_compliance)
    tangential = _cycle_loads(scene)[1]
    loads = _cycle_loads(scene, _FINE_SHARES)[1]
    model = LoopsOverFriction(
        loads, _least_friction(scene), lambda friction: _theory(scene, friction, _FINE_SHARES)
    )
    fit = fit_loop(rows, model, loop.resolution, _OF_THEORY)
    weights = Weights(fit.shift_noise, fit.load_noise)
    nearest = model.nearest_points(rows, fit.friction, fit.terms, weights)
    scale = (fit.highest - fit.lowest) / float(np.ptp(tangential))
    said = [
        (
            f"The rows cover {branches.cycles:.4g} cycles between Q = {fit.lowest:.6g} and"
            f" {fit.highest:.6g}; P was taken over Q as in the scene, so that the form of Q and U"
            " over time counts for nothing"
        ),
        *_said_of_scale(scale),
    ]
    return _Fit(
        scene=scene,
        friction=fit.friction,
        low=fit.low,
        high=fit.high,
        compliance=fit.compliance,
        share=np.mod(nearest.place / (len(loads) - 1), 1.0),
        phase=branches.phase,
        cycles=branches.cycles,
        scale=scale,
        offset=fit.lowest - scale * float(tangential.min()),
        shift_noise=fit.shift_noise,
        load_noise=fit.load_noise,
        said=tuple(said),
        misfit=fit.misfit,
    )


def _share_by_load(
    load: Array, on_rising: NDArray[np.bool_], fit: MasingFit, tangential: Array
) -> Array:
    """Shares of the scene's cycle at which its Q (n_instants,) is that of the rows (n,), on the
    same branch.
    """
    scale = (fit.highest - fit.lowest) / float(np.ptp(tangential))
    bottom = int(np.argmin(tangential[:-1]))
    top = int(np.argmax(tangential[:-1]))
    share = np.empty(len(load))
    for rising in (True, False):
        on_branch = on_rising == rising
        begin = bottom if rising else top
        end = top if rising else bottom
        if end < begin:
            end += _INSTANTS - 1
        instants = np.arange(begin, end + 1)
        if not rising:
            instants = instants[::-1]
        loads = tangential[instants % (_INSTANTS - 1)]
        load_of_scene = tangential[bottom] + (load[on_branch] - fit.lowest) / scale
        share[on_branch] = np.interp(load_of_scene, loads, instants / (_INSTANTS - 1)) % 1.0
    return share


def _against_rows(
    loop: MeasuredLoop,
    shift: Array,
    share: Array,
    load_of_cycle: Array,
    scale: float,
    rig_compliance: float | None,
) -> tuple[float, float, float]:
    """Sum of squares, C and U0 with this U (n_instants,) of theory."""
    load = np.interp(share, SHARES, load_of_cycle)
    rest = loop.shift - scale * np.interp(share, SHARES, shift)
    if rig_compliance is not None:
        rest = rest - rig_compliance * load
        origin = float(np.mean(rest))
        return float(np.sum((rest - origin) ** 2)), rig_compliance, origin
    columns = np.column_stack([load, np.ones(len(share))])
    terms = np.linalg.lstsq(columns, rest, rcond=None)[0]
    return float(np.sum((rest - columns @ terms) ** 2)), float(terms[0]), float(terms[1])


def _fit_over_time(loop: MeasuredLoop, scene: Scene, rig_compliance: float | None) -> _Fit:
    """Where Q has more turning points in a cycle: by the scene's loads at the times of the rows."""
    from scipy.optimize import brentq, minimize_scalar

    place = _on_the_cycle(loop, scene)
    share = place.share
    scale = place.scale
    tangential = _cycle_loads(scene)[1]
    fitted = rig_compliance is None
    least = _least_friction(scene)

    def squares(log_friction: float, share: Array = share, scale: float = scale) -> float:
        shift = _theory(scene, math.exp(log_friction))
        return _against_rows(loop, shift, share, scale * tangential, scale, rig_compliance)[0]

    trials = np.log(least) + np.linspace(1e-6, math.log(_WIDEST), _SCANNED)
    sums = np.array([squares(trial) for trial in trials.tolist()])
    best = int(np.argmin(sums))
    ends = trials[max(best - 1, 0)], trials[min(best + 1, _SCANNED - 1)]

    def best_of(*where: Any) -> float:
        return float(
            minimize_scalar(
                squares, bounds=ends, args=where, method="bounded", options={"xatol": 1e-7}
            ).x
        )

    at = min(best_of(), float(trials[best]), key=squares)
    best_shift = _theory(scene, math.exp(at))
    lowest, compliance, _ = _against_rows(
        loop, best_shift, share, scale * tangential, scale, rig_compliance
    )
    freedom = len(share) - 3 - fitted
    # The scatter is at least what the digits of the rows leave.
    noise = max(math.sqrt(lowest / freedom), loop.resolution[0] / math.sqrt(12))
    limit = lowest + _CHI * noise**2
    friction = scale * math.exp(at)

    def apart(beyond: Array) -> float:
        """How far the f is at which the sum of squares passes the limit, on the way to the nearest
        trial where it has.
        """
        if not len(beyond):
            return math.inf
        far = beyond[np.argmin(np.abs(beyond - at))]
        return abs(
            scale * math.exp(brentq(lambda z: squares(z) - limit, at, far, xtol=1e-7)) - friction
        )

    down, up = (apart(trials[(sums > limit) & side]) for side in (trials < at, trials > at))
    # Noise of Q leaves place and size of the load open. A loop that is shifted in time opens: f is
    # found again with each.
    noise_of_load, place_error, scale_error = _noise_of_load(loop, share, scale, tangential)
    others = (
        (np.mod(share + 1.96 * place_error, 1.0), scale),
        (
            share,
            scale * (1 + 1.96 * scale_error),
        ),
    )
    moved = [other[1] * math.exp(best_of(*other)) - friction for other in others]
    own = friction * _OF_THEORY
    cycles = float(loop.time[-1] / place.period)
    said = [
        (
            f"The rows cover {cycles:.4g} cycles and follow the scene's Q over time to"
            f" {100 * place.misfit:.2g} % of its amplitude"
        ),
        *_said_of_scale(scale),
    ]
    return _Fit(
        scene=scene,
        friction=friction,
        low=max(friction - math.hypot(down, own, *moved), scale * least),
        high=None if math.isinf(up) else friction + math.hypot(up, own, *moved),
        compliance=compliance,
        share=share,
        phase=loop.time / place.period,
        cycles=cycles,
        scale=scale,
        offset=place.offset,
        shift_noise=noise,
        load_noise=max(noise_of_load, loop.resolution[1] / math.sqrt(12)),
        said=tuple(said),
    )


# -------------------------------------------------------------------------------------- the engines
SHARES = np.linspace(0.0, 1.0, _INSTANTS)
# Rows without noise show the chords between instants: to 1e-5 of f they need three times as many.
_FINE_SHARES = np.linspace(0.0, 1.0, 3 * (_INSTANTS - 1) + 1)


def _times(scene: Scene, shares: Array) -> Array:
    """Instants of the last cycle that the scene runs through."""
    path = scene.load.path()
    assert path.period is not None
    return path.cycle_start + path.period * (max(scene.cycles, 2) - 1 + shares)


def _cycle_loads(scene: Scene, shares: Array = SHARES) -> tuple[Array, Array]:
    """P and Q of a cycle."""
    normal, tangential = scene.load.path().at(_times(scene, shares))
    return np.asarray(normal), np.asarray(tangential)


def _theory(scene: Scene, friction: float, shares: Array = SHARES) -> Array:
    """U of the steady cycle by half-plane theory."""
    asked = scene.vary(friction=friction, cycles=max(scene.cycles, 2))
    solution = semi_analytic.solve(
        asked, x=0.0, time=_times(scene, shares), fields="tangential_displacement", cycles="steady"
    )
    return solution.tangential_displacement


def _finite_elements(scene: Scene, friction: float) -> Array:
    """The same by the finite elements, whose instants lie between."""
    import halfplane_fe

    solution = halfplane_fe.solve(scene.vary(friction=friction))
    path = scene.load.path()
    cycle = solution.last_cycle
    assert path.period is not None
    share = (solution.time[cycle] - path.cycle_start) / path.period
    share -= round(float(share[0]))
    return np.interp(SHARES, share, solution.tangential_displacement[cycle])


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


# -------------------------------------------------------------------------------- rows on the cycle
class _Place(NamedTuple):
    """Where rows lie on the cycle (n,); r, Q0 of the file, the period in its time; misfit of Q over
    its amplitude.
    """

    share: Array
    scale: float
    offset: float
    period: float
    misfit: float


def _on_the_cycle(loop: MeasuredLoop, scene: Scene) -> _Place:
    """The place of the rows on the scene's cycle, by their times.

    Raises
    ------
    InputError
        For less than a cycle, and for rows that do not follow the scene's Q.
    """
    tangential = _cycle_loads(scene)[1]
    # Rows of a whole cycle between straight loads are also half of a cycle twice as large: the
    # whole one counts.
    place = _aligned(loop, tangential, _LEAST_CYCLES)
    if place.misfit > _FOLLOWS:
        place = _aligned(loop, tangential)
    cycles = loop.time[-1] / place.period
    if place.misfit > _FOLLOWS:
        raise InputError(
            f"{loop.source}: its Q follows that of {scene.name} to {100 * place.misfit:.0f} % of"
            f" its amplitude only (limit {100 * _FOLLOWS:.0f} %): give a column time, whole cycles,"
            " and a scene with this form of Q"
        )
    if cycles < _LEAST_CYCLES:
        raise InputError(
            f"{loop.source}: its rows cover {cycles:.2g} of a cycle: a loop needs a whole one"
        )
    return place


def _aligned(loop: MeasuredLoop, tangential: Array, least_cycles: float = 0.0) -> _Place:
    """The place of the rows that fits this Q of a cycle best, from starts of at least so many
    cycles.
    """
    from scipy.optimize import minimize

    if not np.ptp(tangential) > 0:
        raise InputError("the scene's Q stands still: there is no loop")
    amplitude = np.ptp(tangential) / 2
    count = len(loop.load)
    even = np.linspace(0.0, loop.time[-1], min(count, 4096))
    wave = np.interp(even, loop.time, loop.load)
    spectrum = np.abs(np.fft.rfft((wave - wave.mean()) * np.hanning(len(wave)), 8 * len(wave)))
    span = loop.time[-1] * len(even) / (len(even) - 1)
    first = (
        max(float(np.argmax(spectrum[4 : 8 * min(_MOST_CYCLES, len(even) // 4)]) + 4) / 8, 0.5)
        / span
    )

    def parts(frequency: float, phase: float) -> tuple[float, Array, float, float]:
        share = np.mod(frequency * loop.time + phase, 1.0)
        own = np.interp(share, SHARES, tangential)
        columns = np.column_stack([own, np.ones(count)])
        scale, offset = np.linalg.lstsq(columns, loop.load, rcond=None)[0].tolist()
        rest = loop.load - scale * own - offset
        # Turned Q fits a sine as well as Q half a cycle later: only the upright one counts.
        return (
            float(np.sqrt(rest @ rest / count))
            + (0.0 if scale > 0 else 10 * float(np.ptp(loop.load))),
            share,
            scale,
            offset,
        )

    # The highest line of a cycle with several waves may be its second or third.
    frequencies = [first / wave * factor for wave in (1, 2, 3) for factor in (0.94, 1.0, 1.06)]
    if first * span < 3:  # a spectrum of a few cycles has no sharp line
        frequencies += (np.arange(0.9, 3.0, 0.05) / span).tolist()
    frequencies = [
        frequency for frequency in frequencies if frequency * loop.time[-1] >= least_cycles
    ] or frequencies
    starts = [(frequency, phase) for frequency in frequencies for phase in np.arange(24) / 24]
    start = min(starts, key=lambda one: parts(*one)[0])
    step = np.array(
        [[0.0, 0.0], [0.3 / max(loop.time[-1] * first, 1.0) * first * 0.3, 0.0], [0.0, 0.02]]
    )
    found = minimize(
        lambda z: parts(*z)[0],
        start,
        method="Nelder-Mead",
        options={
            "initial_simplex": np.array(start) + step,
            "xatol": 1e-9 * first,
            "fatol": 1e-12 * amplitude,
            "maxiter": 800,
        },
    )
    misfit, share, scale, offset = parts(*found.x)
    return _Place(share, scale, offset, float(1 / found.x[0]), misfit / (abs(scale) * amplitude))


def _noise_of_load(
    loop: MeasuredLoop, share: Array, scale: float, tangential: Array
) -> tuple[float, float, float]:
    """Of Q: its noise, and the standard errors that this leaves in the place on the cycle [share]
    and in r, over r.
    """
    own = scale * np.interp(share, SHARES, tangential)
    rest = loop.load - own
    apart = own - own.mean()
    noise = float(np.std(rest))
    rate = np.interp(
        share,
        (SHARES[1:] + SHARES[:-1]) / 2,
        scale * np.diff(tangential) * (_INSTANTS - 1),
        period=1.0,
    )
    return noise, noise / math.sqrt(float(rate @ rate)), noise / math.sqrt(float(apart @ apart))
