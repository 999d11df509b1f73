"""From a foreign result to a ContactSolution: units and signs that can't be, place on the load
path, states, edges, what it lacks.

Each guess follows from the scales of the scene and is a sentence. What is worked out of a result's
fields (states, edges, dissipation) is worked out of the reference's by the same rule, whose error
drops out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.comparison.laws import DERIVED, derived
from reports.comparison.metrics import WHOLE_CYCLE, missing
from reports.scoring.history import History, matched, resultants
from reports.scoring.mapping import Mapping
from reports.scoring.surface import TOUCHES, SurfaceResult, without_spikes
from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    ContactSolution,
    InputError,
    Record,
    Scene,
    Work,
    freeze,
)
from scenes.solution import last_whole_cycle

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A figure of the result over that of theory may lie between these and be right: a frame near
# unloading, a coarse mesh, a wrong body. They are less than a factor of 1000 apart, so that at most
# one factor brings a figure between them.
_LEAST, _MOST = 0.03, 10.0
_FACTORS = (1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9)
# Of the half-width: a contact whose middle is farther from x = 0 was measured from elsewhere.
_OFF_CENTRE = 0.5
_LACKING = "not in the result"
# Instants of a cycle below which the work of friction by the trapezoidal rule means nothing.
_FEWEST = 8
# A point slips where |q| is f p less this share, and, where there is a slip, that has moved by more
# than the second share of the largest movement of the instant. A stick zone ends like the root of
# the distance: one per cent of f p is a ten-thousandth of a.
_CONE = 0.01
_MOVES = 1e-3
# Outermost points in contact that a parabola of p^2 leaves out, points behind them that it takes at
# most and at least, relative residual above which p^2 is no parabola there, spacings by which its
# zero may differ from that of the straight line. Farther in than the share SERIES of the contact
# two terms of a power series are too few: flat-rounded-paper erred by 0.005 a at 0.11.
_RIM, SQUARES, _FEWEST_SQUARES, _ROUGH, _NEAR, _SERIES = 3, 12, 6, 0.005, 0.4, 0.05
# An instant at which no point of the contact moves faster than this share of the largest rate of
# all is at rest: where slip turns, it is the digits of the slip that tell who moves.
_RESTS = 0.02
# Over a_ref: a stick edge of the reference by the rule may be off its own by this; it is by more
# only where slip has just turned and the tractions don't show it yet.
_UNTOLD = 0.05


def contact_solution(
    result: SurfaceResult, mapping: Mapping, whole: ContactSolution, *, sure_of_times: bool = True
) -> tuple[ContactSolution, tuple[str, ...]]:
    """The solution that `result` amounts to, and what was guessed on the way, in sentences.

    Nothing is filled in: what the result does not hold is NaN, named in `work.skipped`, and left
    out of the comparison. Worked out from its own fields, and said so in the notes, are states,
    edges, and of a whole cycle with slip the work of friction. `whole` is the `whole_path` of the
    scene that it answers.

    Raises
    ------
    InputError
        For a history that is not the scene's.
    """
    scene = whole.scene
    result, history, guesses = _placed_on_path(result, mapping, whole, sure_of_times=sure_of_times)
    skipped = _skipped(result, history.time, _instants_of_cycle(scene, history.time))
    if history.guess:
        guesses = (*guesses, history.guess)
    if history.either_sign and mapping.signs.shear is None:  # nothing in the file can tell
        guesses = (
            *guesses,
            (
                "the shear acts on the lower body: its instants were found from the shear itself,"
                " and the scene's path fits it turned round as well (signs.shear, or columns of P"
                " and Q, say it for certain)"
            ),
        )
    normal, tangential, of_scene, notes = (
        result.normal_load,
        result.tangential_load,
        list[str](),
        list[str](),
    )
    if normal is None or tangential is None:
        normal, tangential, of_scene = (
            history.normal_load,
            history.tangential_load,
            ["normal_load", "tangential_load"],
        )
        notes.append("P and Q are the scene's at its instants")
    count = len(history.time)
    nothing, edges = freeze(np.full(count, np.nan)), freeze(np.full((count, 2), np.nan))
    unknown: dict[str, Any] = dict.fromkeys(("contact_edges", "stick_edges"), edges)
    unknown |= dict.fromkeys(
        ("contact_half_width", "stick_half_width", "tangential_displacement", "normal_approach"),
        nothing,
    )
    bare = ContactSolution(
        engine=result.code or Path(result.source).name,
        scene=scene,
        time=freeze(history.time),
        normal_load=freeze(normal),
        tangential_load=freeze(tangential),
        x=result.x,
        pressure=result.pressure,
        shear=result.shear,
        slip=freeze(np.full_like(result.pressure, np.nan)) if result.slip is None else result.slip,
        state=freeze(np.zeros(result.pressure.shape), np.int8),
        **unknown,
        dissipation_density=freeze(np.full(len(result.x), np.nan)),
        dissipation=np.nan,
        cycle_dissipation=freeze([np.nan]),
        permanent_stick_half_width=np.nan,
        steady_from=None,
        record=Record(
            True, "end of path", f"read from {result.source}", freeze(np.zeros(count), np.int64)
        ),
        work=Work({"instants": count, "points": len(result.x)}, skipped),
        **_imposed(scene, history.time),
        settings={
            "source": result.source,
            DERIVED: ["state", "contact_edges", "stick_edges", *of_scene],
        }
        | ({"element_size": mapping.element_size} if mapping.element_size else {}),
    )
    solution, how = _ruled(bare, slip=result.slip is not None, work="dissipation" not in skipped)
    if "dissipation" not in skipped:
        steps = len(solution.last_cycle)
        notes.insert(
            0,
            f"its dissipation is the sum of q ds of its own shear and slip over the {steps}"
            " instants of a cycle",
        )
    said = (*result.notes, *history.notes, how, *notes)
    solution = replace(solution, record=replace(solution.record, notes=said))
    return solution, (*guesses, *_oddities(result, history.tangential_load, scene))


def _placed_on_path(
    result: SurfaceResult, mapping: Mapping, whole: ContactSolution, *, sure_of_times: bool
) -> tuple[SurfaceResult, History, tuple[str, ...]]:
    """`result` in the scene's units and our signs, its instants on the load path, and what was
    guessed.

    A single cell that stands out of all others tells nothing of units and instants: they are found
    without it, and it is put back.
    """
    fields = {"pressure": result.pressure, "shear": result.shear}
    if result.slip is not None:
        fields["slip"] = result.slip
    without: dict[str, Any] = {name: without_spikes(values) for name, values in fields.items()}
    plain = replace(result, **without)
    guessed, guesses = _guessed(plain, mapping, whole)
    history = matched(guessed, whole.scene, sure_of_times=sure_of_times)
    if not result.outliers:
        return guessed, history, guesses
    spiked = {name: getattr(guessed, name).copy() for name in fields}
    for outlier in result.outliers:
        # The factor and the sign that its field was given.
        before, after = getattr(plain, outlier.quantity), getattr(guessed, outlier.quantity)
        largest = np.unravel_index(np.argmax(np.abs(before)), before.shape)
        factor = float(after[largest] / before[largest]) if before[largest] else 1.0
        spiked[outlier.quantity][outlier.instant, outlier.point] = factor * outlier.value
    put_back: dict[str, Any] = {name: freeze(values) for name, values in spiked.items()}
    return (
        replace(guessed, **put_back),
        history,
        (*(outlier.sentence for outlier in result.outliers), *guesses),
    )


def _ruled(of: ContactSolution, *, slip: bool, work: bool) -> tuple[ContactSolution, str]:
    """A solution with states, edges, permanent stick zone and moments from its own tractions, and
    how they were told, in words.

    `slip`: the slip helps to tell what slips; `work`: the dissipation is the sum of q ds over its
    last cycle.
    """
    friction, sheared = of.scene.friction.coefficient, not np.isnan(of.shear).all()
    state, contact, stick, how = zones(
        of.x, of.pressure, of.shear, of.slip if slip else None, friction, of.time
    )
    steps = of.last_cycle if WHOLE_CYCLE not in of.work.skipped else np.arange(0)
    if not sheared:
        how = (
            f"{_IN_CONTACT}; without a shear nothing says what slips, and what touches is drawn as"
            " sticking"
        )
        stick = np.full_like(stick, np.nan)
    ends = np.full(2, np.nan)
    if (
        len(steps)
        and not np.isnan(stick[steps]).any()
        and stick[steps, 1].min() > stick[steps, 0].max()
    ):
        ends = np.array([stick[steps, 0].max(), stick[steps, 1].min()])
    known: dict[str, Any] = {
        "state": freeze(state, np.int8),
        "contact_edges": freeze(contact),
        "stick_edges": freeze(stick),
        "contact_half_width": freeze(np.diff(contact, axis=1)[:, 0] / 2),
        "stick_half_width": freeze(np.diff(stick, axis=1)[:, 0] / 2),
        "permanent_stick_half_width": float(ends[1] - ends[0]) / 2,
    }
    if of.scene.unsymmetric:
        known["moment"] = freeze(np.trapezoid(of.x * of.pressure, of.x, axis=1))
        if sheared:
            known["shear_moment"] = freeze(np.trapezoid(of.x * of.shear, of.x, axis=1))
            known["permanent_stick_edges"] = freeze(ends)
    if work:
        density = friction_work(of.shear[steps], of.slip[steps])
        whole = float(np.trapezoid(density, of.x))
        known |= {
            "dissipation": whole,
            "dissipation_density": freeze(density),
            "cycle_dissipation": freeze([whole]),
        }
    return replace(of, **known), how


def by_same_rule(
    reference: ContactSolution, result: ContactSolution, length: float
) -> tuple[ContactSolution, tuple[str, ...]]:
    """`reference` with states, edges and dissipation by the rules that gave `result` its own, and
    how far the rules are off.

    The metrics then are about the result and not about the rules. A result that states everything
    itself leaves the reference as it is; so does, of the dissipation, a reference on other instants
    than the result's. `length` is a_ref.
    """
    if "state" not in derived(result):
        return reference, ()
    lacks = missing(result)
    work = np.array_equal(reference.time, result.time) and "dissipation" not in lacks
    found, _ = _ruled(reference, slip="slip" not in lacks, work=work)
    own, by_rule = reference.stick_edges, found.stick_edges
    # Instants at which the rule finds the reference's own stick edges; all, where those are the
    # fewer.
    told = np.isnan(own[:, 0]) == np.isnan(by_rule[:, 0])
    told &= np.max(np.abs(np.nan_to_num(own - by_rule)), axis=1) <= _UNTOLD * length
    told = told if 2 * told.sum() > len(told) else np.ones_like(told)
    contact, stick = (
        float(np.nanmax(np.abs(one - other), initial=0.0)) / length
        for one, other in (
            (reference.contact_edges, found.contact_edges),
            (own[told], by_rule[told]),
        )
    )
    where = (
        f"; at {int((~told).sum())} of {len(told)} instants it can't tell the stick edges, which"
        " are not judged"
    )
    words = [
        "States and edges follow from one rule in the result and in the reference; against the"
        f" reference's own it errs by up to {contact:.1e} a_ref at the contact edge and {stick:.1e}"
        f" a_ref at the stick edge{'' if told.all() else where}."
    ]
    if work:
        share = (
            100 * (found.dissipation / reference.dissipation - 1) if reference.dissipation else 0.0
        )
        words.append(
            "Dissipation is compared by one rule, the sum of q ds over "
            f"{len(found.last_cycle)} instants and {len(found.x)} points; "
            f"of the reference that rule gives {share:+.2g} % more than its own."
        )
    return replace(found, stick_edges=freeze(np.where(told[:, None], by_rule, np.nan))), tuple(
        words
    )


def _imposed(scene: Scene, time: Array) -> dict[str, Any]:
    """Bulk stresses and tilt of the scene at the instants; of a tilt that follows from a moment the
    tractions say nothing.
    """
    path, found = scene.load.path(), dict[str, Any]()
    for name, keys in (
        ("bulk", ("bulk_stress_lower", "bulk_stress_upper")),
        ("turning", ("tilt",)),
    ):
        own = path.companion(name)
        values = np.zeros((2, len(time))) if own is None else own.at(np.maximum(time, path.start))
        if scene.unsymmetric and (name == "bulk" or not path.moment_given):
            found |= {key: freeze(value) for key, value in zip(keys, values, strict=False)}
    return found


def _instants_of_cycle(scene: Scene, time: Array) -> int:
    """How many instants the last whole cycle has (of a path that is not periodic: all, if they go
    from its start to its end).
    """
    path = scene.load.path()
    if path.period is None:
        tolerance = 1e-6 * (path.initial_loading[-1].end - path.start)
        whole = (
            time[0] <= path.start + tolerance
            and time[-1] >= path.initial_loading[-1].end - tolerance
        )
        return len(time) if whole else 0
    steps, whole = last_whole_cycle(time, path.period, path.cycle_start)
    return len(steps) if whole else 0


def _skipped(result: SurfaceResult, time: Array, steps: int) -> dict[str, tuple[int, str]]:
    """What the result lacks, with the reason; `steps` instants of it are a whole cycle."""
    lacking = dict.fromkeys(("tangential_displacement", "normal_approach", "loop_work"), _LACKING)
    if result.slip is None:
        lacking["slip"] = _LACKING
    if not result.sheared:
        lacking |= {"shear": _LACKING} | dict.fromkeys(
            ("state", "stick_edges"), f"{_LACKING}; it takes the shear"
        )
    if not steps:
        lacking[WHOLE_CYCLE] = f"{_LACKING}, which goes from time {time[0]:.6g} to {time[-1]:.6g}"
    takes = {
        "; it takes the shear": not result.sheared,
        "; it takes slip": result.slip is None,
        "; it takes a whole cycle, or a whole path from the unloaded start": not steps,
        f", for a cycle of {steps} instants is too coarse to work it out (less than {_FEWEST})": (
            steps < _FEWEST
        ),
    }
    if why := next((words for words, lacks in takes.items() if lacks), ""):
        lacking |= dict.fromkeys(("dissipation", "dissipation_density"), _LACKING + why)
    return {name: (len(time), why) for name, why in lacking.items()}


def friction_work(shear: Array, slip: Array) -> Array:
    """Sum of q ds over the instants by the trapezoidal rule: (k, n), (k, n) -> (n,).

    >>> friction_work(np.array([[0.0], [2.0]]), np.array([[0.0], [3.0]])).tolist()
    [3.0]
    """
    return np.asarray(np.sum((shear[1:] + shear[:-1]) / 2 * np.diff(slip, axis=0), axis=0))


# -------------------------------------------------------------------------- contact, stick and slip
class Zones(NamedTuple):
    """state (n_steps, n_points) as int8; contact_edges and stick_edges (n_steps, 2) [length]; how
    they were told, in words.
    """

    state: NDArray[np.int8]
    contact_edges: Array
    stick_edges: Array
    how: str


_IN_CONTACT = f"in contact is a point with more than {TOUCHES:g} of the instant's largest pressure"


def zones(
    x: Array, pressure: Array, shear: Array, slip: Array | None, friction: float, time: Array
) -> Zones:
    """States and edges of tractions on points, (n_steps, n_points), and of their slip where there
    is one.

    In full stick the stick edges are the contact edges, in full slip NaN, as everywhere in the
    project.

    A contact edge lies where the straight line of p^2 through the last two points in contact is 0,
    a stick edge where that of (f p - |q|)^2 is, each no farther than the next point: both are roots
    of the distance at an edge. The outermost points are the mesh's own: a parabola of p^2 through
    those behind them gives the contact edge where it fits. Which points slip: those on the Coulomb
    limit, whose slip, where there is one, moves with the shear; the first instant has no step
    before it, so that there the limit alone tells.
    """
    touching = pressure > TOUCHES * pressure.max(axis=1, keepdims=True)
    slips, sense = touching & (np.abs(shear) >= (1 - _CONE) * friction * pressure), np.sign(shear)
    words, told = _IN_CONTACT, "tractions"
    if friction:
        words += f"; it slips where |q| is at least {1 - _CONE:g} f p"
    if slip is not None and len(slip) > 1:
        moved = np.where(touching[1:], np.diff(slip, axis=0), 0.0)
        largest = np.max(np.abs(moved), axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = np.where(largest > 0, largest / np.diff(time)[:, None], 0.0)
        far = (np.abs(moved) > _MOVES * largest) & (rate >= _RESTS * np.max(rate))
        if friction:
            slips = np.vstack([slips[:1], slips[1:] & far & (np.sign(moved) == sense[1:])])
            told = "tractions and slip"
            words += (
                f" and its slip has moved with the shear by more than {_MOVES:g} of the instant's"
                f" largest step, unless no point moves faster than {_RESTS:g} of the largest rate"
            )
        else:
            slips, sense = np.vstack([slips[:1], far]), np.vstack([sense[:1], np.sign(moved)])
    elif friction:
        words += "; for want of slip, a point that just came to rest still counts as slipping"
    state = np.where(
        touching, np.where(slips, np.where(sense > 0, SLIP_FORWARD, SLIP_REVERSE), STICK), OPEN
    ).astype(np.int8)
    sticks, short = touching & ~slips, np.maximum(friction * pressure - np.abs(shear), 0.0)
    contact = np.array(
        [_ends(x, row**2, here, smooth=True) for row, here in zip(pressure, touching, strict=True)]
    )
    stick = np.array([_ends(x, row**2, here) for row, here in zip(short, sticks, strict=True)])
    # where the outermost points of the contact stick, the stick zone ends with it
    for k in range(len(stick)):
        inside = np.flatnonzero(touching[k])
        for side, at in ((0, 0), (1, -1)):
            if len(inside) and sticks[k, inside[at]]:
                stick[k, side] = contact[k, side]
    return Zones(state, contact, stick, f"states and edges are worked out from its {told}: {words}")


def _ends(x: Array, square: Array, inside: Mask, *, smooth: bool = False) -> tuple[float, float]:
    """Left and right end of `inside`, where `square` (n,) goes to 0, as a power series if `smooth`;
    NaN where nothing is inside.
    """
    points = np.flatnonzero(inside)
    if not len(points):
        return np.nan, np.nan

    def end(last: int, outward: int) -> float:
        """Where the line through the points `last` and the one before is 0, between `last` and the
        next point; or the parabola.
        """
        following, before = last + outward, last - outward
        if not 0 <= following < len(x):
            return float(x[last])
        reach = abs(float(x[following] - x[last]))
        if not 0 <= before < len(x) or square[before] <= square[last]:
            return float(x[last]) + outward * reach / 2
        spacing = abs(float(x[last] - x[before]))
        line = float(x[last]) + outward * min(
            float(square[last] / (square[before] - square[last])) * spacing, reach
        )
        # fewer points where a corner of the profile is among them
        for share in (1, 2, 4) if smooth else ():
            count = min(SQUARES, len(points) // 2 - _RIM) // share
            nodes = last - outward * (_RIM + np.arange(count))
            if count < _FEWEST_SQUARES or abs(x[last] - x[nodes[-1]]) > _SERIES * abs(
                x[points[-1]] - x[points[0]]
            ):
                continue
            away, values = outward * (x[nodes[0]] - x[nodes]) / spacing, square[nodes]
            a, b, c = fit = np.polyfit(away, values, 2, w=1 / values)
            rough, under = np.std(np.polyval(fit, away) / values), b**2 - 4 * a * c
            zero = float(x[nodes[0]] + outward * spacing * 2 * c / (b + np.sqrt(max(under, 0.0))))
            if b > 0 and under > 0 and rough < _ROUGH and abs(zero - line) <= _NEAR * spacing:
                return zero
        return line

    return end(int(points[0]), -1), end(int(points[-1]), 1)


# -------------------------------------------------------------------- units and signs that can't be
def whole_path(scene: Scene) -> ContactSolution:
    """Half-widths and loads of half-plane theory through the whole path, at the engine's own
    instants.
    """
    import semi_analytic

    return semi_analytic.solve(scene, x=[0.0], fields=())


def _guessed(
    result: SurfaceResult, mapping: Mapping, theory: ContactSolution
) -> tuple[SurfaceResult, tuple[str, ...]]:
    """`result` in the scene's units and our signs, and a sentence for each guess that took.

    What the mapping states is never guessed at. `theory` is that of the scene's `whole_path`.

    Raises
    ------
    InputError
        For a pressure that is zero everywhere, or nowhere compression by the sign that the mapping
        states.
    """
    if not np.any(result.pressure):
        raise InputError(
            f"{result.source}: the pressure is zero at every point and instant: nothing to score"
        )
    if mapping.signs.pressure is not None and result.pressure.max() <= 0:
        raise InputError(
            f"{result.source}: by signs.pressure = {mapping.signs.pressure!r} of the mapping no"
            " point is in compression: state the other sign, or leave it out"
        )
    sentences: list[str] = []
    if mapping.signs.pressure is None and result.pressure.max() <= TOUCHES * -result.pressure.min():
        result = replace(result, pressure=freeze(0.0 - result.pressure))
        sentences.append(
            "the pressure is negative throughout: compression was taken to be negative"
            ' (signs.pressure = "compression negative")'
        )
    if (
        result.normal_load is not None
        and result.normal_load.max() <= 1e-9 * -result.normal_load.min()
    ):
        result = replace(result, normal_load=freeze(0.0 - result.normal_load))
        sentences.append(
            "the normal load is negative throughout and was turned: here P > 0 presses"
        )

    for yardstick in _yardsticks(result, theory):
        result, sentence = _in_units_of(yardstick, result, mapping)
        if sentence:
            sentences.append(sentence)

    left, right = _extent(result)
    half_width = float(np.nanmax(theory.contact_half_width))
    edges = (np.nanmin(theory.contact_edges[:, 0]), np.nanmax(theory.contact_edges[:, 1]))
    centre = float(edges[0] + edges[1]) / 2 if theory.tilt is not None else 0.0
    if (
        not mapping.x_offset
        and abs((left + right) / 2 - centre) > _OFF_CENTRE * half_width
        and right - left <= 4 * half_width
    ):
        pressure = result.pressure[int(np.argmax(result.pressure.max(axis=1)))]
        load = np.trapezoid(pressure, result.x)
        centroid = float(np.trapezoid(pressure * result.x, result.x) / load)
        shift = centroid - centre
        result = replace(result, x=freeze(result.x - shift))
        by = ", by the centroid" if centre else ", the centroid"
        sentences.append(
            f"x was counted from {shift:.6g}{by} of the largest pressure, where the file has it"
            " from 0 (x_offset)"
        )
    return result, tuple(sentences)


@dataclass(frozen=True)
class _Yardstick:
    """By what a unit is guessed: a value of the result beside the one that theory has.

    Attributes
    ----------
    key
        of the mapping's factors
    fields
        of the result, that have this unit
    words
        for these fields
    measured, expected
        the value in the result, and theory's
    quantity
        what both are, in a sentence
    """

    key: str
    fields: tuple[str, ...]
    words: str
    measured: float
    expected: float
    quantity: str

    @property
    def theory_in_words(self) -> str:
        """Theory's value in a sentence; of pressure it is the mean, so the least."""
        if self.key == "stress":
            return f"at least the mean one, {self.expected:.4g},"
        return f"{self.expected:.4g}"

    @property
    def factor(self) -> float:
        """The first of the usual factors that brings the result near theory; 1 if none does."""
        for factor in (1.0, *_FACTORS):
            if _LEAST <= self.measured / self.expected * factor <= _MOST:
                return factor
        return 1.0


def _yardsticks(result: SurfaceResult, theory: ContactSolution) -> tuple[_Yardstick, ...]:
    """Half-width, pressure and normal load, at the largest load."""
    left, right = _extent(result)
    half_width = float(np.nanmax(theory.contact_half_width))
    load = float(np.max(theory.normal_load))
    largest_load = 0.0 if result.normal_load is None else float(np.max(result.normal_load))
    return (
        _Yardstick(
            "length",
            ("x", "slip"),
            "x",
            (right - left) / 2,
            half_width,
            "the contact's half-width is",
        ),
        _Yardstick(
            "stress",
            ("pressure", "shear"),
            "pressure and shear",
            float(result.pressure.max()),
            load / (2 * half_width),
            "the largest pressure is",
        ),
        _Yardstick(
            "load",
            ("normal_load", "tangential_load"),
            "P and Q",
            largest_load,
            load,
            "the largest P is",
        ),
    )


def _in_units_of(
    yardstick: _Yardstick, result: SurfaceResult, mapping: Mapping
) -> tuple[SurfaceResult, str]:
    """The result with the guessed factor, and the sentence that says so; empty where none is."""
    fields = {name: getattr(result, name) for name in yardstick.fields}
    known = {name: values for name, values in fields.items() if values is not None}
    is_stated = getattr(mapping.factors, yardstick.key) is not None
    factor = yardstick.factor
    if is_stated or not known or not yardstick.measured or factor == 1.0:
        return result, ""
    scaled: dict[str, Any] = {name: freeze(values * factor) for name, values in known.items()}
    sentence = (
        f"{yardstick.words} multiplied by {factor:g}, for {yardstick.quantity}"
        f" {yardstick.measured:.4g} and theory has {yardstick.theory_in_words} "
        f"(factors.{yardstick.key} = {factor:g} says it for certain)"
    )
    return replace(result, **scaled), sentence


def _extent(result: SurfaceResult) -> tuple[float, float]:
    """Leftmost and rightmost x that carries pressure at any instant."""
    touched = result.x[(result.pressure > TOUCHES * result.pressure.max()).any(axis=0)]
    return float(touched[0]), float(touched[-1])


def _oddities(result: SurfaceResult, tangential: Array, scene: Scene) -> Iterator[str]:
    """Signs that look wrong and are scored as they are; `tangential` is Q of the scene at the
    result's instants.
    """
    if result.pressure.min() < -TOUCHES * result.pressure.max():
        row, column = np.unravel_index(np.argmin(result.pressure), result.pressure.shape)
        yield (
            f"the pressure is tension at some points, down to {result.pressure[row, column]:.4g} at"
            f" x = {result.x[column]:.4g} of instant {row + 1}; it is scored as it is"
        )
    force = resultants(result)[1]
    if float(force @ tangential) < -0.5 * float(np.linalg.norm(force) * np.linalg.norm(tangential)):
        yield (
            "the shear is opposite to Q in the mean: it looks like the shear on the upper body; it"
            ' is scored as it is (signs.shear = "on upper" turns it)'
        )
    if result.slip is not None and scene.friction.coefficient and len(result.slip) > 1:
        work = (result.shear[1:] + result.shear[:-1]) / 2 * np.diff(result.slip, axis=0)
        if float(np.sum(work)) < -0.5 * float(np.sum(np.abs(work))):
            yield (
                "the slip goes against the shear, so that friction would feed energy in: it looks"
                ' like lower over upper; it is scored as it is (signs.slip = "lower over upper"'
                " turns it)"
            )
