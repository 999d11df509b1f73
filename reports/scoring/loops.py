"""A measured loop of Q over the relative displacement U as the reference: which f fits it, and how theory and finite elements lie.

# notation: A = 2/E*, C compliance of the rig, f friction coefficient, W area of the loop, tau time on the scene's cycle,
#           r factor of the file's Q over the scene's

A rig measures U beside the loads, and in it its own elastic compliance:

    U = r U(tau; f/r) + C Q + U0 + noise,   Q = r Q(tau) + Q0 + noise

where U(tau; f) is that of the steady cycle of the scene. Loads that are r times as large with the same f slip as those of the scene
with f/r. U of half-planes hangs on a datum length by a term that is linear in Q at constant P: a fitted C takes it in, a given one
is that of the rig beyond `profile.datum_length`. C and U0 are found by linear least squares, f by a scan and a bounded search on
the sum of squares, and its interval is where that sum exceeds the least one by what chance gives in 95 %.

tau follows from the order of the rows, or from their times: period and phase are those with which Q fits the scene's best. At
constant P nothing depends on the form of Q over time: a sine and straight lines are tried in place of the scene's.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.charts.plate import Axis, Curve, Dot, Key, Mark, Panel, Plate, Rule, limits, worded
from reports.charts.templating import script, template
from reports.checking import nearest_to_sliding
from reports.comparison.words import question
from reports.folder import filled
from reports.scoring.mapping import Mapping, converted, find_column, listed
from reports.units import energy_unit, load_unit, minus, units
from scenes import EllipseLoad, InputError, PolygonLoad, Scene
from scenes.text_tables import plain, text_table
from scenes.unit_words import unit_factor

Array = NDArray[np.float64]
Against = Literal["exact", "fe"]

_SHIFT_NAMES = ("U", "u", "displacement", "relative displacement", "tangential displacement", "shift", "slip", "U1")
_FEWEST, _LEAST_CYCLES, _MOST_CYCLES = 40, 0.9, 2000
# Parts of the cycle in which rows are averaged for the area.
_PARTS = 200
# Instants of a cycle at which theory is evaluated, straight between: an error of 1e-5 of the range of U.
_INSTANTS = 721
# Coefficients that are scanned, from gross sliding to so many times as much; beyond, a loop is a line.
_SCANNED, _WIDEST = 60, 40.0
# Rows that do not follow the scene's Q better than this share of its amplitude are another experiment's.
_FOLLOWS = 0.15
# Chance gives so much of the sum of squares over its mean in 95 %: chi squared of one degree.
_CHI = 3.841


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """Rows of a rig: `shift` U and `load` Q, (n,) in the units of the scene, `time` (n,) in any; `said` what was assumed."""

    source: str
    shift: Array
    load: Array
    time: Array
    said: tuple[str, ...]


@dataclass(frozen=True)
class LoopRow:
    """One loop: area W [energy per thickness] and its uncertainty, slope dU/dQ of the straight line through it [1/stress].

    `friction` is its coefficient, None of the measured one; `distance` the root mean square of its distances in U from the means of
    the rows in each part of the cycle [length], NaN of the measured one.
    """

    name: str
    friction: float | None
    area: float
    area_uncertainty: float
    slope: float
    distance: float


@dataclass(frozen=True, eq=False)
class LoopScore:
    """What a measured loop says.

    Attributes
    ----------
    friction, low, high : f that fits best and its 95 % interval; high None where no larger f can be told from it
    compliance, compliance_fitted : of the rig [1/stress]
    scale : r, the file's Q over the scene's
    cycles : how many the rows cover
    noise : rms of U about the best fit [length]
    rows : measured, then each computed loop
    said : what was assumed
    tau, shift, load, curves : the rows on the cycle [share], and each computed loop (U with the rig, Q), for the figure
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
    said: tuple[str, ...]
    tau: Array
    shift: Array
    load: Array
    curves: tuple[tuple[str, Array, Array], ...]

    @property
    def agrees(self) -> bool:
        """Whether the scene's own f lies in the interval."""
        return self.low <= self.scene.friction.coefficient <= (math.inf if self.high is None else self.high)

    @property
    def sentence(self) -> str:
        """The finding."""
        own, high = self.scene.friction.coefficient, "no upper limit" if self.high is None else f"{self.high:.4g}"
        lies = "lies within" if self.agrees else "lies outside"
        return (
            f"The loop is best fitted by f = {self.friction:.4g} (95 %: {self.low:.4g} to {high}); the scene's f = {own:.4g} "
            f"{lies} this interval."
        )


def read_loop(path: Path, mapping: Mapping, scene: Scene) -> MeasuredLoop:
    """The columns U and Q of a table, and its time if there is one.

    Raises
    ------
    InputError
        As the reader of tables; for a column that is missing or in a unit that can't be turned into the scene's, for too few rows.
    """
    table = text_table(path)
    names, where = table.names, str(path)
    force = find_column(mapping, "tangential_load", names, where, needed=True)
    stated = find_column(mapping, "slip", names, where) if mapping.columns.slip else None
    shifts = [name for alias in _SHIFT_NAMES for name in names if plain(name) == plain(alias)]
    shift = stated or next(iter(dict.fromkeys(shifts)), None)
    if shift is None:
        raise InputError(
            f"{where}: no column for the relative displacement (looked for {', '.join(_SHIFT_NAMES[:4])} ...) among "
            f"{listed(names)}; name it by columns.slip of a mapping"
        )
    assert force is not None
    time = find_column(mapping, "time", names, where)
    said, times = [f"U is the column {shift!r} and Q the column {force!r}"], {shift: 1.0, force: 1.0}
    columns: tuple[tuple[str, float | None, Literal["length", "load"], str], ...] = (
        (shift, mapping.factors.length, "length", units(scene)[1]),
        (force, mapping.factors.load, "load", load_unit(scene)),
    )
    for name, factor, key, wanted in columns:
        inside = table.units[names.index(name)]
        if inside and inside != wanted and factor is None:
            with contextlib.suppress(ValueError):
                times[name], per_length = unit_factor(inside, key, scene.units)
                if key == "length" or per_length:
                    said.append(f"The column {name!r} is in {inside}: times {times[name]:.9g}")
                    continue
            raise InputError(
                f"{where}: the column {name!r} is in {inside}, and the scene in {wanted}: state factors.{key} in a mapping, by "
                "which it is multiplied"
            )
    count = len(table.values)
    if count < _FEWEST:
        raise InputError(f"{where}: {count} rows are too few for a loop: at least {_FEWEST} are needed")
    rows = np.arange(count, dtype=float) if time is None else table.column(time)
    back = np.flatnonzero(np.diff(rows) <= 0)
    if len(back):
        k = int(back[0]) + 1
        raise InputError(f"{where}, line {table.lines[k]}: {time} = {rows[k]:.6g} does not ascend: rows stand in the order of time")
    found = {"slip": times[shift] * table.column(shift), "tangential_load": times[force] * table.column(force)}
    u, q = (converted(mapping, name, values) for name, values in found.items())  # type: ignore[arg-type]
    for name, values in ((shift, u), (force, q)):
        if not np.ptp(values) > 0:
            raise InputError(f"{where}: {name} is the same in every row: there is no loop")
    said.append("Rows follow each other evenly in time" if time is None else f"Times of the rows are the column {time!r}")
    return MeasuredLoop(where, u, q, rows - rows[0], tuple(said))


def score_loop(loop: MeasuredLoop, scene: Scene, *, rig_compliance: float | None = None, against: Against = "exact") -> LoopScore:
    """The f that fits a measured loop best, its interval, and the loops of the engines beside it.

    Parameters
    ----------
    rig_compliance : C [1/stress], beyond the datum length of the profile; fitted if None
    against : "fe" has the finite elements solve the scene with its own f and with the best one too

    Raises
    ------
    InputError
        For a scene whose loads do not repeat or have no Q, for rows that cover less than a cycle or do not follow its Q.

    >>> from scenes import load_scene
    >>> scene = load_scene("cattaneo-mindlin")  # f = 0.5
    >>> path, share = scene.load.path(), np.arange(200) / 100
    >>> times = path.cycle_start + path.period * (1 + np.arange(101) / 100)
    >>> exact = semi_analytic.solve(scene, x=0.0, time=times, fields="tangential_displacement")
    >>> row = np.arange(200) % 100
    >>> rig = exact.tangential_displacement + 1e-5 * exact.tangential_load
    >>> found = score_loop(MeasuredLoop("rig", rig[row], exact.tangential_load[row], share, ()), scene)
    >>> round(found.friction, 3), round(found.compliance, 7)
    (0.5, 1e-05)
    """
    from scipy.optimize import brentq, minimize_scalar

    if scene.load.path().period is None:
        raise InputError(f"{scene.name}: its loads do not repeat: a loop needs a cycle")
    if scene.unsymmetric:
        raise InputError(
            f"{scene.name}: no measured loop is scored with bulk stress, tilt or unequal sides: U hangs on where it is measured, "
            "and the loop's area is not the dissipation"
        )
    scene, place, said = _on_the_cycle(loop, scene)
    share, scale, tangential = place.share, place.scale, _cycle_loads(scene)[1]
    own, fitted, known = tangential * scale, rig_compliance is None, rig_compliance or 0.0
    least = nearest_to_sliding(scene).ratio * scene.friction.coefficient * (1 + 1e-9)

    def against_rows(shift: Array, share: Array = share, scale: float = scale) -> tuple[float, float, float]:
        """Sum of squares, C and U0 with this U (n_instants,) of theory."""
        load = scale * np.interp(share, _SHARES, tangential)
        rest = loop.shift - scale * np.interp(share, _SHARES, shift) - known * load
        columns = np.column_stack([load, np.ones(len(share))][not fitted :])
        found = np.linalg.lstsq(columns, rest, rcond=None)[0]
        return float(np.sum((rest - columns @ found) ** 2)), float(found[0]) if fitted else known, float(found[-1])

    def squares(log_friction: float, *where: Any) -> float:
        return against_rows(_theory(scene, math.exp(log_friction)), *where)[0]

    trials = np.log(least) + np.linspace(1e-6, math.log(_WIDEST), _SCANNED)
    sums = np.array([squares(trial) for trial in trials.tolist()])
    best = int(np.argmin(sums))
    ends = trials[max(best - 1, 0)], trials[min(best + 1, _SCANNED - 1)]

    def best_of(*where: Any) -> float:
        return float(minimize_scalar(squares, bounds=ends, args=where, method="bounded", options={"xatol": 1e-7}).x)

    at = min(best_of(), float(trials[best]), key=squares)
    (lowest, compliance, _), freedom = against_rows(_theory(scene, math.exp(at))), len(share) - 3 - fitted
    noise, limit, friction = math.sqrt(lowest / freedom), lowest * (1 + _CHI / freedom), scale * math.exp(at)

    def apart(beyond: Array) -> float:
        """How far the f is at which the sum of squares passes the limit, on the way to the nearest trial where it has."""
        if not len(beyond):
            return math.inf
        far = beyond[np.argmin(np.abs(beyond - at))]
        return abs(scale * math.exp(brentq(lambda z: squares(z) - limit, at, far, xtol=1e-7)) - friction)

    down, up = (apart(trials[(sums > limit) & side]) for side in (trials < at, trials > at))
    # Noise of Q leaves place and size of the load open. A loop that is shifted in time opens: f is found again with each.
    noise_of_load, place_error, scale_error = _noise_of_load(loop, share, scale, tangential)
    others = (np.mod(share + 1.96 * place_error, 1.0), scale), (share, scale * (1 + 1.96 * scale_error))
    moved = [other[1] * math.exp(best_of(*other)) - friction for other in others]

    rows, curves = [_measured_row(loop, share, own, noise, noise_of_load)], []

    def add(name: str, coefficient: float, shift: Array) -> None:
        _, slope, origin = against_rows(shift)
        whole = scale * shift + slope * own + origin
        area = scale**2 * float(np.sum((tangential[1:] + tangential[:-1]) / 2 * np.diff(shift)))
        _, rest = _means(share, loop.shift - np.interp(share, _SHARES, whole))
        rows.append(LoopRow(name, coefficient, area, 0.0, _slope(whole, own), math.sqrt(float(np.mean(rest**2)))))
        curves.append((name, whole, own + place.offset))

    cases = {"best f": math.exp(at), "the scene's f": scene.friction.coefficient / scale}
    for name, coefficient in cases.items():
        if coefficient < least:
            said.append(f"With {name}, {scale * coefficient:.4g}, the measured loads slide grossly: there is no such loop")
            continue
        add(f"theory, {name}", scale * coefficient, _theory(scene, coefficient))
        if against == "fe":
            add(f"finite elements, {name}", scale * coefficient, _finite_elements(scene, coefficient))
    return LoopScore(
        scene=scene,
        source=loop.source,
        friction=friction,
        low=max(friction - math.hypot(down, *moved), scale * least),
        high=None if math.isinf(up) else friction + math.hypot(up, *moved),
        compliance=compliance,
        compliance_fitted=fitted,
        scale=scale,
        cycles=float(loop.time[-1] / place.period),
        noise=noise,
        rows=tuple(rows),
        said=(*loop.said, *said),
        tau=share,
        shift=loop.shift,
        load=loop.load,
        curves=tuple(curves),
    )


# ------------------------------------------------------------------------------------------------------------ the engines
_SHARES = np.linspace(0.0, 1.0, _INSTANTS)


def _times(scene: Scene) -> Array:
    """Instants of the last cycle that the scene runs through."""
    path = scene.load.path()
    assert path.period is not None
    return path.cycle_start + path.period * (max(scene.cycles, 2) - 1 + _SHARES)


def _cycle_loads(scene: Scene) -> tuple[Array, Array]:
    """P and Q of a cycle."""
    normal, tangential = scene.load.path().at(_times(scene))
    return np.asarray(normal), np.asarray(tangential)


def _theory(scene: Scene, friction: float) -> Array:
    """U of the steady cycle by half-plane theory."""
    asked = scene.vary(friction=friction, cycles=max(scene.cycles, 2))
    solution = semi_analytic.solve(asked, x=0.0, time=_times(scene), fields="tangential_displacement", cycles="steady")
    return solution.tangential_displacement


def _finite_elements(scene: Scene, friction: float) -> Array:
    """The same by the finite elements, whose instants lie between."""
    import halfplane_fe

    solution = halfplane_fe.solve(scene.vary(friction=friction))
    path, cycle = scene.load.path(), solution.last_cycle
    assert path.period is not None
    share = (solution.time[cycle] - path.cycle_start) / path.period
    share -= round(float(share[0]))
    return np.interp(_SHARES, share, solution.tangential_displacement[cycle])


def _slope(shift: Array, load: Array) -> float:
    """dU/dQ of the straight line through a loop."""
    apart = load - load.mean()
    return float(apart @ shift / (apart @ apart))


def _means(share: Array, *values: Array) -> tuple[Array, ...]:
    """Rows in each part of the cycle that has any, and the mean of each of `values` (n,) there: (k,) each."""
    parts = np.floor(share * max(_FEWEST // 2, min(_PARTS, len(share) // 8))).astype(int)
    count = np.bincount(parts)
    some = count > 0
    return (count[some].astype(float), *(np.bincount(parts, one)[some] / count[some] for one in values))


def _measured_row(loop: MeasuredLoop, share: Array, own: Array, noise: float, noise_of_load: float) -> LoopRow:
    """The loop as measured: - closed integral of U dQ through the means of the rows in each part of the cycle.

    Q is that which the rows follow; its noise counts as well, since it leaves open where on the cycle they are.
    """
    load = np.interp(share, _SHARES, own)
    count, shifts, loads = _means(share, loop.shift, load)
    step = (np.roll(loads, -1) - np.roll(loads, 1)) / 2
    across = (np.roll(shifts, -1) - np.roll(shifts, 1)) / 2
    error = 1.96 * math.sqrt(float(np.sum((noise**2 * step**2 + noise_of_load**2 * across**2) / count)))
    return LoopRow("measured", None, -float(shifts @ step), error, _slope(loop.shift, load), math.nan)


# ------------------------------------------------------------------------------------------------- rows on the cycle
class _Place(NamedTuple):
    """Where rows lie on the cycle (n,); r, Q0 of the file, the period in its time; misfit of Q over its amplitude."""

    share: Array
    scale: float
    offset: float
    period: float
    misfit: float


def _on_the_cycle(loop: MeasuredLoop, scene: Scene) -> tuple[Scene, _Place, list[str]]:
    """The scene whose form of Q the rows follow, their place on its cycle, and what was found.

    Raises
    ------
    InputError
        For less than a cycle, and for rows that follow neither the scene's Q nor, at constant P, a sine or straight lines.
    """
    chosen, name, place = scene, "the scene's", _aligned(loop, _cycle_loads(scene)[1])
    for form, trial in _other_forms(scene).items():
        found = _aligned(loop, _cycle_loads(trial)[1])
        if found.misfit < 0.98 * place.misfit:
            chosen, name, place = trial, form, found
    cycles = loop.time[-1] / place.period
    if place.misfit > _FOLLOWS:
        raise InputError(
            f"{loop.source}: its Q follows that of {scene.name} to {100 * place.misfit:.0f} % of its amplitude only (limit "
            f"{100 * _FOLLOWS:.0f} %): give a column time, whole cycles, and a scene with this form of Q"
        )
    if cycles < _LEAST_CYCLES:
        raise InputError(f"{loop.source}: its rows cover {cycles:.2g} of a cycle: a loop needs a whole one")
    said = [f"The rows cover {cycles:.4g} cycles and follow {name} Q over time to {100 * place.misfit:.2g} % of its amplitude"]
    if abs(place.scale - 1) > 1e-3:
        words = "loads as in the file were taken, P as in the scene"
        said.append(f"Q of the file is {place.scale:.4g} times that of the scene: {words}")
    return chosen, place, said


def _other_forms(scene: Scene) -> dict[str, Scene]:
    """At constant P: a sine and straight lines between the same extremes of Q."""
    normal, tangential = _cycle_loads(scene)
    turns = np.count_nonzero(np.diff(np.sign(np.diff(tangential)[np.abs(np.diff(tangential)) > 1e-9 * np.ptp(tangential)])))
    if np.ptp(normal) > 1e-9 * normal.max() or turns > 2:
        return {}
    mean, size, load = (float(value) for value in ((tangential.max() + tangential.min()) / 2, np.ptp(tangential) / 2, normal[0]))
    sine = EllipseLoad(mean_normal_load=load, mean_tangential_load=mean, tangential_amplitude=size)
    lines = PolygonLoad(initial_loading=[(load, 0.0)], cycle=[(load, mean + size), (load, mean - size)])
    return {"a sine's": scene.vary(load=sine), "a triangle's": scene.vary(load=lines)}


def _aligned(loop: MeasuredLoop, tangential: Array) -> _Place:
    """The place of the rows that fits this Q of a cycle best."""
    from scipy.optimize import minimize

    if not np.ptp(tangential) > 0:
        raise InputError("the scene's Q stands still: there is no loop")
    amplitude, count = np.ptp(tangential) / 2, len(loop.load)
    even = np.linspace(0.0, loop.time[-1], min(count, 4096))
    wave = np.interp(even, loop.time, loop.load)
    spectrum = np.abs(np.fft.rfft((wave - wave.mean()) * np.hanning(len(wave)), 8 * len(wave)))
    span = loop.time[-1] * len(even) / (len(even) - 1)
    first = max(float(np.argmax(spectrum[4 : 8 * min(_MOST_CYCLES, len(even) // 4)]) + 4) / 8, 0.5) / span

    def parts(frequency: float, phase: float) -> tuple[float, Array, float, float]:
        share = np.mod(frequency * loop.time + phase, 1.0)
        own = np.interp(share, _SHARES, tangential)
        columns = np.column_stack([own, np.ones(count)])
        scale, offset = np.linalg.lstsq(columns, loop.load, rcond=None)[0].tolist()
        rest = loop.load - scale * own - offset
        # Turned Q fits a sine as well as Q half a cycle later: only the upright one counts.
        return float(np.sqrt(rest @ rest / count)) + (0.0 if scale > 0 else 10 * float(np.ptp(loop.load))), share, scale, offset

    starts = [(first * factor, phase) for factor in (0.94, 1.0, 1.06) for phase in np.arange(24) / 24]
    start = min(starts, key=lambda one: parts(*one)[0])
    step = np.array([[0.0, 0.0], [0.3 / max(loop.time[-1] * first, 1.0) * first * 0.3, 0.0], [0.0, 0.02]])
    found = minimize(
        lambda z: parts(*z)[0],
        start,
        method="Nelder-Mead",
        options={"initial_simplex": np.array(start) + step, "xatol": 1e-9 * first, "fatol": 1e-12 * amplitude, "maxiter": 800},
    )
    misfit, share, scale, offset = parts(*found.x)
    return _Place(share, scale, offset, float(1 / found.x[0]), misfit / (abs(scale) * amplitude))


def _noise_of_load(loop: MeasuredLoop, share: Array, scale: float, tangential: Array) -> tuple[float, float, float]:
    """Of Q: its noise, and the standard errors that this leaves in the place on the cycle [share] and in r, over r."""
    own = scale * np.interp(share, _SHARES, tangential)
    rest = loop.load - own
    apart = own - own.mean()
    noise = float(np.std(rest))
    rate = np.interp(share, (_SHARES[1:] + _SHARES[:-1]) / 2, scale * np.diff(tangential) * (_INSTANTS - 1), period=1.0)
    return noise, noise / math.sqrt(float(rate @ rate)), noise / math.sqrt(float(apart @ apart))


# ------------------------------------------------------------------------------------------------------------ page and JSON
def content(found: LoopScore) -> dict[str, Any]:
    """A loop score for JSON."""
    return {
        "kind": "loop",
        "passed": found.agrees,
        "sentence": found.sentence,
        "friction": {"value": found.friction, "low": found.low, "high": found.high, "scene": found.scene.friction.coefficient},
        "rig_compliance": {"value": found.compliance, "fitted": found.compliance_fitted},
        "scale": found.scale,
        "cycles": found.cycles,
        "noise": found.noise,
        "metrics": {row.name: {name: value for name, value in vars(row).items() if name != "name"} for row in found.rows},
        "notes": list(found.said),
        "scene": found.scene.model_dump(mode="json"),
    }


def table(found: LoopScore) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heads and rows: each loop, and how far it is from the measured one."""
    length, stress = units(found.scene)[1:]
    area, distance = f"area W [{energy_unit(found.scene)}]", f"mean rows − loop, rms [{length}]"
    heads = ("loop", "f", area, "W/measured − 1", f"slope dU/dQ [1/{stress}]", distance)
    measured = found.rows[0]
    rows: list[tuple[str, ...]] = []
    for row in found.rows:
        apart = "–" if row is measured else minus(f"{100 * (row.area / measured.area - 1):+.2g} %")
        spread = f" ± {row.area_uncertainty:.1g}" if row.area_uncertainty else ""
        friction = "–" if row.friction is None else f"{row.friction:.4g}"
        distance = f"{row.distance:.3g}" if math.isfinite(row.distance) else "–"
        rows.append((row.name, friction, f"{row.area:.5g}{spread}", apart, f"{row.slope:.5g}", distance))
    return heads, rows


def _plates(found: LoopScore) -> tuple[Plate, ...]:
    """The loop, U less the straight line through it, so that it opens; and rows minus the best fit."""
    length, load, line = units(found.scene)[1], load_unit(found.scene), found.rows[1].slope
    base, rest = float(np.mean(found.shift - line * found.load)), found.shift - np.interp(found.tau, _SHARES, found.curves[0][1])
    count, share, shifts, loads, means = _means(found.tau, found.tau, found.shift, found.load, rest)
    opened = shifts - line * loads - base
    curves = [Curve(q, u - line * q - base, f"line-{k}", name) for k, (name, u, q) in enumerate(found.curves, 1)]
    keys = [Key(curve.css, curve.label) for curve in curves]

    def panel(
        name: str, words: str, height: float, across: Axis, up: Axis, dots: tuple[Array, Array], lines: Sequence[Mark]
    ) -> Panel:
        marks = [Dot(x, y, "p0", 2.2) for x, y in zip(*(values.tolist() for values in dots), strict=True)]
        return Panel(name, across, up, [*marks, *lines], words, 900.0, height, css="broad")

    axes = (
        Axis(*limits(loads, curves[0].x), f"Q  [{load}]"),
        Axis(*limits(opened, *(c.y for c in curves)), f"U − slope Q  [{length}]"),
    )
    below = Axis(0.0, 1.0, "share of the cycle"), Axis(*limits(means), f"mean rows − best fit  [{length}]")
    loop = panel("loop", "Loop of displacement over tangential load", 380.0, *axes, (loads, opened), curves)
    residuals = panel("loop-rest", "Residuals of the best fit over the cycle", 260.0, *below, (share, means), [Rule(0.0, "zero")])
    words: dict[str, Any] = {"fewest": f"{count.min():.0f}", "most": f"{count.max():.0f}", "parts": len(count), "columns": 1}
    columns = {"tau": found.tau, f"Q [{load}]": found.load, f"U [{length}]": found.shift}
    noise: dict[str, Any] = {"noise": f"{found.noise:.3g}", "length": length}
    return (
        worded("loop", [loop], columns, keys, slope=f"{line:.4g}", **words),
        worded("loop_residuals", [residuals], {"tau": found.tau, f"U - fit [{length}]": rest}, **noise, **words),
    )


def write(found: LoopScore, out: str | Path, command: str) -> Path:
    """The page, loop.json and the CSV of each figure; returns the path of the page."""
    from reports.comparison.words import strict

    program, digest = script()
    drawings, (heads, rows) = _plates(found), table(found)
    with filled(out) as folder:
        (folder / "figures").mkdir()
        for drawing in drawings:
            (folder / "figures" / f"{drawing.name}.csv").write_text(drawing.csv(), encoding="utf-8")
        whole = strict(content(found)) | {"command": command}
        (folder / "loop.json").write_text(json.dumps(whole, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        page = template("loop.html").render(
            title=f"Measured loop: {Path(found.source).name}",
            scene=found.scene,
            question=question(found.scene),
            found=found,
            stress=units(found.scene)[2],
            heads=heads,
            rows=rows,
            drawings=drawings,
            command=command,
            script=program,
            script_hash=digest,
        )
        (folder / "report.html").write_text(page, encoding="utf-8")
    return Path(out) / "report.html"
