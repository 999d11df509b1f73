"""The answer to a scene whose rig prescribes displacements, by corrected theory, as `Findings`: the
loads of `driven`, and the fields of `corrected` under them.

The answer's scene states the loads that were found, in the place of the displacements: a polygon
with a point for each instant. Cycles before the steady one are part of its initial loading.

Every value is taken from steps half as long as those that its error is stated by. At constant P W
does not depend on the steps.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from scenes import BodyEffects, Hertz, InputError, PolygonLoad, Rig, Scene
from scenes.array_types import Array
from scenes.errors import first_line
from semi_analytic.answer import Findings, Question, mirrored_points, neglected_coupling
from semi_analytic.answer_by_memory import folded
from semi_analytic.corrected import (
    OF_RIG,
    OddPart,
    PathRows,
    PathSeries,
    PointFields,
    certificates_of,
    curvatures_of,
    grids_at,
    instants_of,
    left_of_work,
    notes_of_effects,
    odd_part_on_grids,
    permanent_stick,
    series_at,
    table_of,
)
from semi_analytic.corrected_memory import Curvatures, PunchTable, follow
from semi_analytic.driven import (
    ActuatorRows,
    Compliance,
    Driven,
    actuator_rows,
    follow_actuator,
    loads_of_approach,
)
from semi_analytic.elasticity import composite_modulus
from semi_analytic.next_order import (
    has_next_order,
    left_of_tilt_and_strain,
    ratio_of_next_order,
    without_next_order,
)
from semi_analytic.odd_memory import ODD_NUMBERS, Declined
from semi_analytic.odd_part_of_rig import loads_of_cycle, odd_part_of_rig
from semi_analytic.profiles import SymmetricContact, contact_of

# Share of f P by which the memory curves of two cycles may differ and be the same state.
_STEADY = 1e-9
_PLACES = 200
# Rows on the two steps around the end of a slide, and ends that have them.
_ROWS_AT_END = 33
_MOST_ENDS = 200
# Slides of this share of the way of the actuator are round-off.
_NO_SLIDE = 1e-9
# Straight steps of a cycle on grids, which take few.
_STEPS_ON_GRIDS = 55
# Of a path that `odd_part_of_rig` states again: the second cycle is steady, if not the first.
_STEADY_CYCLE = 1
# Slides that a note names one by one.
_MOST_NAMED = 4


# ------------------------------------------------------------------------------------ the movements
@dataclass(frozen=True, eq=False)
class Rigged:
    """A scene with prescribed displacements, ready to be followed.

    Attributes
    ----------
    scene
        as asked
    contact, modulus, effects
        normal contact of half-planes, E*, what the bodies add
    compliance
        of contact and rig
    """

    scene: Scene
    contact: SymmetricContact
    modulus: float
    effects: BodyEffects
    compliance: Compliance

    def follow(self, cycles: int, finer: int, further: Array | None = None) -> Driven:
        """The path by steps, `finer` times as many as at least, with rows at `further` (k,)."""
        path = self.scene.load.path_of_actuators()
        return self.follow_rows(actuator_rows(path, cycles, finer, further))

    def follow_rows(self, rows: ActuatorRows) -> Driven:
        """The path by given steps."""
        scene = self.scene
        if scene.load.states_approach:
            loads = loads_of_approach(self.contact, self.modulus, self.compliance, rows.normal)
            rows = rows._replace(normal=loads)
        table = self._table(rows)
        largest_load = float(np.max(rows.normal))
        self.compliance.require_unique(float(table.half_width(table.last)), largest_load)
        return follow_actuator(table, scene.friction.coefficient, self.compliance, rows)

    def _table(self, rows: ActuatorRows) -> PunchTable:
        """Flat punches up to the largest contact, whatever Q is."""
        if not np.any(rows.normal > 0):
            raise InputError(
                "load: P is never positive, so that the bodies never touch; it is a compression"
            )
        bend = self.compliance.curvatures
        limit = self.scene.friction.coefficient * rows.normal
        widest = -np.sign(bend.normal_under_shear) * limit
        loads = PathRows(rows.time, rows.normal, widest, rows.ends, None)
        return table_of(self.contact, self.modulus, loads, bend)


def rigged(scene: Scene, effects: BodyEffects | None) -> Rigged:
    """The scene with the compliance of its contact and its rig.

    Raises
    ------
    InputError
        For real bodies without their effects.
    """
    rig = scene.rig
    if effects is None:
        if not scene.bodies.half_planes:
            raise InputError(
                "load.tangential_displacement: the displacement of these bodies is not that of"
                " half-planes; give effects = halfplane_fe.body_effects(scene)"
            )
        assert rig.datum_length is not None  # for the type checker: the scene was checked
        effects = BodyEffects(datum_length=rig.datum_length)
    modulus = composite_modulus(scene.material)
    compliance = Compliance(
        unit=2 / (math.pi * modulus),
        datum_length=effects.datum_length,
        normal=effects.normal_compliance.value,
        tangential=effects.tangential_compliance.value,
        normal_spring=1 / (rig.normal_stiffness or math.inf),
        tangential_spring=1 / (rig.tangential_stiffness or math.inf),
        curvatures=curvatures_of(effects),
        tilts=_tilts_of(scene, effects),
    )
    contact = contact_of(scene.profile, scene.material)
    return Rigged(scene, contact, modulus, effects, compliance)


def _tilts_of(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
    """R alpha_P alpha_Q and R alpha_Q^2 [1 / (stress load)]; 0 where the profile is no parabola, of
    which alone the moment under a tilt is known.
    """
    if not isinstance(scene.profile, Hertz):
        return 0.0, 0.0
    under_shear = effects.tilt_under_shear.value
    under_pressure = effects.tilt_under_pressure.value
    radius = scene.profile.radius
    return radius * under_pressure * under_shear, radius * under_shear**2


class _Slide(NamedTuple):
    """One stretch of gross sliding."""

    begin: float  # time
    end: float
    way: float  # signed, of the upper body over the lower along +x [length]
    work: float  # f P times the way [energy / thickness]


def slides_of(driven: Driven, rows: slice) -> list[_Slide]:
    """The stretches of gross sliding in some rows, whose first ends the step before them."""
    numbers = np.arange(len(driven.time))[rows]
    way_of_actuator = float(np.ptp(driven.actuator)) or 1.0
    direction = np.sign(driven.slide)
    direction[np.abs(driven.slide) <= _NO_SLIDE * way_of_actuator] = 0
    slides: list[_Slide] = []
    for before, row in pairwise(numbers.tolist()):
        if not direction[row]:
            continue
        part = _Slide(
            float(driven.time[before]),
            float(driven.time[row]),
            float(driven.slide[row]),
            float(driven.slide_work[row]),
        )
        if slides and slides[-1].end == part.begin and slides[-1].way * part.way > 0:
            first = slides[-1]
            slides[-1] = _Slide(first.begin, part.end, first.way + part.way, first.work + part.work)
        else:
            slides.append(part)
    return slides


# --------------------------------------------------------------------------------- the whole answer
def of_rig(question: Question) -> Findings:
    """The answer to a scene with prescribed displacements.

    Raises
    ------
    InputError
        As `rigged`, `Compliance.require_unique` and `corrected` do; for `straight_steps`.
    """
    started = clock.perf_counter()
    if question.straight_steps:
        raise InputError(
            "straight_steps: it goes with given loads; leave it out where a displacement is"
            " prescribed"
        )
    rig = rigged(question.scene, question.effects)
    driven, coarse, steady_from = _followed(rig, question.time)
    last_cycle, rows = _rows_of(driven, question.scene, steady_from)
    bodies = _series(rig, driven)
    of_coarse = _series(rig, coarse)
    history_done = clock.perf_counter()

    x = question.x
    if x is None:
        x = mirrored_points(1.05 * float(np.max(bodies.half_width)))
    distance, fold = folded(x)
    time, numbers = instants_of(question, rows, last_cycle)
    points = PointFields(bodies, distance)
    grids = grids_at(question, points, distance, numbers)
    same_loads = _SameLoads.of(rig, driven, last_cycle)
    odd = _odd_part(rig, driven, last_cycle, steady_from, same_loads)
    of_odd_numbers = odd.work(_STEADY_CYCLE)
    work = driven.work(last_cycle) + of_odd_numbers.value + same_loads.of_next_order
    errors = _errors(driven, coarse, steady_from)
    if work > 0:
        of_bodies = of_odd_numbers.uncertainty + same_loads.uncertainty
        errors["dissipation"] = errors.get("dissipation", 0.0) + of_bodies / work
    if odd.left_out:
        errors["dissipation"] = math.nan  # how much tilt and strain add is not known
    loop = math.nan
    # The displacement has the moment of the tilt, and not what makes the work in the second order.
    if steady_from is not None and rows.period is not None and odd == OddPart():
        loop = bodies.loop_work(last_cycle)
        coarse_cycle, _ = _rows_of(coarse, question.scene, steady_from)
        if loop > 0:
            errors["loop_work"] = abs(of_coarse.loop_work(coarse_cycle) / loop - 1)
    density = np.full(len(distance), np.nan)
    if question.wants("dissipation_density"):
        density = points.work(last_cycle)
    wants_work = question.wants("dissipation")
    series = series_at(question, bodies, numbers)
    to_datum = _to_datum_of_answers(rig)
    series["tangential_displacement"] = (
        series["tangential_displacement"] + to_datum * series["tangential_load"]
    )
    series["normal_approach"] = series["normal_approach"] + to_datum * series["normal_load"]
    values: dict[str, Any] = {
        **series,
        **{name: np.take(grid, fold, axis=1) for name, grid in grids.items()},
        "permanent_stick_half_width": permanent_stick(bodies, last_cycle),
        "dissipation": work if wants_work else math.nan,
        "loop_work": loop if wants_work else math.nan,
        "cycle_dissipation": np.array([work if wants_work else math.nan]),
        "dissipation_density": density[fold],
        "steady_from": None if steady_from is None else 0,
    }
    return Findings(
        time=time,
        x=x,
        values=values,
        termination="end of path" if steady_from is None else "steady",
        message=_message(steady_from, question.scene),
        notes=tuple(_notes(rig, driven, last_cycle, errors, odd)),
        errors={name: error for name, error in errors.items() if error},
        certificates=certificates_of(bodies, grids, numbers),
        counts={
            "points_evaluated": len(distance),
            "rows": len(driven.time),
            "pieces": len(driven.followed.pieces.top),
        },
        seconds={
            "history": history_done - started,
            "fields": clock.perf_counter() - history_done,
        },
        scene=_scene_of_loads(question.scene, rows, last_cycle),
    )


class _SameLoads(NamedTuple):
    """What the loads of a cycle that were found make of other bodies.

    Attributes
    ----------
    of_curvatures
        change of the friction work of slip by the bodies, over half-planes, minus 1
    of_next_order
        work that the next order of the bodies adds; 0 where it is left out
    uncertainty
        of the work, by the order after the next
    """

    of_curvatures: float = 0.0
    of_next_order: float = 0.0
    uncertainty: float = 0.0

    @classmethod
    def of(cls, rig: Rigged, driven: Driven, rows: slice) -> _SameLoads:
        """Of the bodies of a rig."""
        if rig.scene.bodies.half_planes or _no_next_order(driven, rows):
            return cls()
        followed = driven.followed
        loads = (followed.normal_load, followed.tangential_load)
        by_rows = (followed.table, followed.friction, *loads)
        theory = PathSeries(follow(*by_rows, Curvatures()), rig.contact, rig.modulus, None)
        of_half_planes = theory.work(rows)
        if not of_half_planes > 0:
            return cls()
        with_bodies = follow(*by_rows, curvatures_of(rig.effects), theory.followed)
        bodies = PathSeries(with_bodies, rig.contact, rig.modulus, rig.effects)
        by_curvatures = float(np.sum(driven.slip_work[rows][1:]))
        return cls(
            of_curvatures=bodies.work(rows) / of_half_planes - 1,
            of_next_order=bodies.work(rows) - by_curvatures,
            uncertainty=left_of_work(bodies, theory, rows, rig.effects) * of_half_planes,
        )


def _odd_part(
    rig: Rigged,
    driven: Driven,
    last_cycle: slice,
    steady_from: int | None,
    same_loads: _SameLoads,
) -> OddPart:
    """What tilt and bulk strain of the bodies make of the dissipation of the steady cycle."""
    if not any(getattr(rig.effects, name).value for name in ODD_NUMBERS):
        return OddPart()
    if steady_from is None:
        return OddPart(left_out="no cycle is steady")
    try:
        odd = OddPart(odd_part_of_rig(rig.scene, rig.effects, driven, last_cycle))
    except Declined as reason:
        odd = _odd_part_on_grids(rig, driven, last_cycle, str(reason))
    half_width = float(rig.contact.half_width(np.max(driven.followed.normal_load)))
    ratio = ratio_of_next_order(rig.effects, half_width)
    return odd._replace(left=left_of_tilt_and_strain(same_loads.of_curvatures, ratio))


def _odd_part_on_grids(rig: Rigged, driven: Driven, last_cycle: slice, reason: str) -> OddPart:
    """The same on grids, where the second order does not hold for that reason.

    Grids follow the loads that were found. Where they take neither, it is left out.
    """
    if np.any(driven.slide[last_cycle][1:] != 0):
        return OddPart(left_out=reason)
    try:
        of_loads = loads_of_cycle(rig.scene, driven, last_cycle, _STEPS_ON_GRIDS)
    except (Declined, InputError) as fault:
        return OddPart(left_out=f"{reason}, and grids do not take it: {first_line(fault)}")
    return odd_part_on_grids(of_loads, rig.effects, driven.work(last_cycle), reason)


def _no_next_order(driven: Driven, last_cycle: slice) -> str:
    """Why the next order of the bodies is left out; empty where it is not."""
    if np.any(driven.slide[last_cycle][1:] != 0):
        return "the bodies slide as a whole"
    return ""


def _to_datum_of_answers(rig: Rigged) -> float:
    """(A/pi) ln(L0/L) of half-planes: L0 is where every answer counts its displacements from, L
    where the rig prescribes them [1 / stress]; 0 of bodies.
    """
    if not rig.scene.bodies.half_planes:
        return 0.0
    ratio = rig.scene.profile.datum_length / rig.compliance.datum_length
    return rig.compliance.unit * math.log(ratio)


def _series(rig: Rigged, driven: Driven) -> PathSeries:
    """Of the curvatures, which the loads were found with."""
    effects = without_next_order(rig.effects)
    return PathSeries(driven.followed, rig.contact, rig.modulus, effects, driven.free)


def _followed(rig: Rigged, time: Array | None) -> tuple[Driven, Driven, int | None]:
    """The path until a cycle ends in the state that it started from, by steps and by steps twice as
    long; the index of that cycle, None where none does.
    """
    scene = rig.scene
    repeats = scene.load.path_of_actuators().period is not None
    most_cycles = max(scene.cycles, 2) if repeats else 0
    for cycles in range(min(2, most_cycles), most_cycles + 1):
        coarse = rig.follow(cycles, 1)
        is_last = cycles == most_cycles
        if steady_cycle(coarse) is None and not is_last:
            continue
        near_ends = _near_ends_of_slides(coarse)
        further = _within_cycles(scene, near_ends, cycles)
        if len(near_ends):
            coarse = rig.follow(cycles, 1, further)
        if time is not None:
            further = np.append(further, _within_cycles(scene, time, cycles))
        driven = rig.follow(cycles, 2, further)
        # Other steps may leave a little at the end of a stroke, which the next cycle takes away.
        steady_from = _steady_in_both(driven, coarse)
        if steady_from is not None or is_last:
            break
    return driven, coarse, steady_from if repeats else None


def _steady_in_both(driven: Driven, coarse: Driven) -> int | None:
    """The first cycle that is steady by both steps."""
    cycles = (steady_cycle(driven), steady_cycle(coarse))
    return None if None in cycles else max(cycle for cycle in cycles if cycle is not None)


def _near_ends_of_slides(driven: Driven) -> Array:
    """Instants (k,) around those at which a slide ends while P varies: there the actuator turns
    round against what the contact gives way, which no row of the path shows.
    """
    slides = driven.slide != 0
    load = driven.followed.normal_load
    last = np.flatnonzero(slides[1:-1] & ~slides[2:]) + 1
    last = last[load[last + 1] != load[last]][:_MOST_ENDS]
    begin = driven.time[last - 1]
    share = np.linspace(0.0, 1.0, _ROWS_AT_END)[:, None]
    return (begin + share * (driven.time[last + 1] - begin)).ravel()


def _within_cycles(scene: Scene, time: Array, cycles: int) -> Array:
    """Instants (k,) of any cycle in each of those that are followed."""
    path = scene.load.path_of_actuators()
    if path.period is None:
        return time
    share = np.mod(time - path.cycle_start, path.period)
    in_cycles = path.cycle_start + share + path.period * np.arange(cycles)[:, None]
    return np.concatenate([time[time < path.cycle_start], in_cycles.ravel()])


def steady_cycle(driven: Driven) -> int | None:
    """The first cycle that ends in the state it started from."""
    followed = driven.followed
    s = np.linspace(0.0, followed.table.last, _PLACES)
    allowed = _STEADY * followed.friction * float(np.max(followed.normal_load))
    states = [followed.frozen_force(row, s) for row in driven.ends]
    for number, (before, after) in enumerate(pairwise(states)):
        if np.max(np.abs(after - before)) <= allowed:
            return number
    return None


def _rows_of(driven: Driven, scene: Scene, steady_from: int | None) -> tuple[slice, PathRows]:
    """The rows of the last cycle that is answered, and those up to its end; of a path without a
    steady cycle all rows.
    """
    period = scene.load.path_of_actuators().period
    followed = driven.followed
    begin = 0
    end = len(driven.time) - 1
    ends: tuple[int, ...] = (end,)
    if steady_from is None:
        period = None
    else:
        begin = driven.ends[steady_from]
        end = driven.ends[steady_from + 1]
        ends = (begin, end)
    rows = PathRows(
        driven.time[: end + 1],
        followed.normal_load[: end + 1],
        followed.tangential_load[: end + 1],
        ends,
        period,
    )
    return slice(begin, end + 1), rows


def _scene_of_loads(scene: Scene, rows: PathRows, last_cycle: slice) -> Scene:
    """The scene with P and Q at the rows in the place of the displacements."""
    loads = np.stack([rows.normal_load, rows.tangential_load], axis=1)
    points = [(float(normal), float(tangential)) for normal, tangential in loads]
    loading = tuple(points[1:])
    cycle: tuple[tuple[float, float], ...] = ()
    if rows.period is not None:
        loading = tuple(points[1 : last_cycle.start + 1])
        cycle = tuple(points[last_cycle.start + 1 : -1])
    load = PolygonLoad(initial_loading=loading, cycle=cycle, times=tuple(rows.time.tolist()))
    return scene.vary(load=load, rig=Rig(), cycles=1)


def _errors(driven: Driven, coarse: Driven, steady_from: int | None) -> dict[str, float]:
    """Differences of steps and of steps twice as long, over W and over the largest |Q|."""
    errors = {}
    whole = slice(0, None)
    if steady_from is not None:
        whole = slice(driven.ends[steady_from], driven.ends[steady_from + 1] + 1)
    of_coarse = slice(0, None)
    if steady_from is not None:
        of_coarse = slice(coarse.ends[steady_from], coarse.ends[steady_from + 1] + 1)
    work = driven.work(whole)
    if work > 0:
        errors["dissipation"] = abs(coarse.work(of_coarse) / work - 1)
    force = driven.followed.tangential_load
    largest = float(np.max(np.abs(force)))
    if largest > 0:
        _, place, place_in_coarse = np.intersect1d(driven.time, coarse.time, return_indices=True)
        difference = force[place] - coarse.followed.tangential_load[place_in_coarse]
        errors["tangential_load"] = float(np.max(np.abs(difference))) / largest
    return errors


def _message(steady_from: int | None, scene: Scene) -> str:
    """How the path ended, in a sentence."""
    if steady_from is not None:
        return f"cycle {steady_from + 1} ends in the state it started from"
    if scene.load.path_of_actuators().period is None:
        return "the path was followed to its end"
    return f"no steady cycle among the first {max(scene.cycles, 2)}: the whole path is answered"


# ---------------------------------------------------------------------------------------- the words
def _notes(
    rig: Rigged, driven: Driven, last_cycle: slice, errors: dict[str, float], odd: OddPart
) -> Iterator[str]:
    """What a reader must not miss."""
    scene = rig.scene
    force, length, _ = scene.unit_words
    yield from neglected_coupling(scene.material)
    if scene.bodies.half_planes:
        yield (
            "rig: the displacements are prescribed at half-planes, in the distance"
            f" {rig.effects.datum_length:.6g} {length} from the contact; U and approach here count"
            f" from {scene.profile.datum_length:.6g} {length}, as in every answer"
        )
    else:
        yield (
            "rig: the displacements are prescribed at the bases of the bodies; corrected theory is"
            " implied"
        )
        half_width = float(rig.contact.half_width(np.max(driven.followed.normal_load)))
        modulus = composite_modulus(scene.material)
        if has_next_order(rig.effects):
            yield _note_of_next_order(rig, driven, last_cycle)
        yield from notes_of_effects(rig.effects, half_width, modulus, odd, OF_RIG)
    spring = rig.compliance.tangential_spring
    if spring:
        actuator = float(np.ptp(driven.actuator[last_cycle]))
        contact = float(np.ptp(driven.displacement[last_cycle]))
        yield (
            f"rig: of the range {actuator:.6g} {length} of the actuator the contact takes"
            f" {contact:.6g}, the spring the rest"
        )
    largest = float(np.max(np.abs(driven.followed.tangential_load)))
    yield (
        "rig: P and Q follow from the displacements, at constant P without an error of the steps;"
        f" here Q is uncertain by {errors.get('tangential_load', 0.0) * largest:.2g} of at most"
        f" {largest:.6g} {force}/{length}"
    )
    yield from notes_of_slides(scene, driven, last_cycle)
    if np.any(driven.followed.normal_load[1:] <= 0):
        yield "separation: the bodies part, and nothing is remembered after it"


def _note_of_next_order(rig: Rigged, driven: Driven, last_cycle: slice) -> str:
    """Where the next order counts, and what it would change where it does not."""
    left_out = _no_next_order(driven, last_cycle)
    where = f"left out: {left_out}" if left_out else "in the dissipation"
    rows = np.array([0.0, np.max(driven.followed.normal_load)])
    without = without_next_order(rig.effects)
    pressures = []
    half_widths = []
    for effects in (rig.effects, without):
        pressed = follow(driven.followed.table, 1.0, rows, 0 * rows, curvatures_of(effects))
        series = PathSeries(pressed, rig.contact, rig.modulus, effects)
        half_width = float(series.half_width[1])
        places = np.linspace(0.0, half_width, _PLACES)
        pressures.append(float(np.max(PointFields(series, places).pressure(np.array([1])))))
        half_widths.append(half_width)
    return (
        f"effects: the next order of the bodies, N_4, T_4, N_22 and T_22, is {where}, and in no"
        f" other value: of the largest pressure it would make"
        f" {100 * (pressures[0] / pressures[1] - 1):+.2g} %, of the largest half-width"
        f" {100 * (half_widths[0] / half_widths[1] - 1):+.2g} %"
    )


def notes_of_slides(scene: Scene, driven: Driven, last_cycle: slice) -> Iterator[str]:
    """When the bodies slide as a whole and how far, in the last cycle and before it, or on the
    path.
    """
    force, length, _ = scene.unit_words
    energy = f"{force}·{length}/{length}"
    what = "the last cycle" if last_cycle.start else "the path"
    slides = slides_of(driven, last_cycle)
    before = slides_of(driven, slice(0, last_cycle.start + 1)) if last_cycle.start else []
    if not slides:
        yield f"gross sliding: none in {what}"
    else:
        way = sum(abs(slide.way) for slide in slides)
        work = sum(slide.work for slide in slides)
        named = "; ".join(_in_words(slide, length) for slide in slides[:_MOST_NAMED])
        more = f"; and {len(slides) - _MOST_NAMED} more" if len(slides) > _MOST_NAMED else ""
        yield (
            f"gross sliding: in {what} the bodies slide as a whole by {way:.6g} {length}, which"
            f" takes {work:.6g} {energy} of the dissipation: {named}{more}"
        )
    if before:
        yield f"gross sliding: before it {'; '.join(_in_words(s, length) for s in before[:2])}"


def _in_words(slide: _Slide, length: str) -> str:
    direction = "forward" if slide.way > 0 else "back"
    return (
        f"from time {slide.begin:.6g} to {slide.end:.6g} {direction} by {abs(slide.way):.6g}"
        f" {length}"
    )
