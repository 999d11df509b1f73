"""The page of a scene whose rig prescribes a displacement: the loop at the contact and at the
actuator, what the contact does over time, and how far the bodies slide as a whole.

All of it is of one answer, by either engine; its loads follow from the displacement. Where theory
and finite elements both take the scene, the loop and W of the latter stand beside those of theory.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from reports import input_words
from reports.charts.plate import (
    Axis,
    Block,
    Curve,
    Key,
    Mark,
    Panel,
    Plate,
    Rule,
    axis_limits,
    figure_with_texts,
    write_tables,
)
from reports.charts.templating import Table, script, template
from reports.comparison.pairs import engine_in_words
from reports.comparison.words import row_of_sliding, summary_rows
from reports.folder import results_folder
from reports.inputs import InputEffects
from reports.units import energy_unit, load_unit, minus, units
from scenes import ContactSolution, Scene
from scenes.array_types import Array, Indices

_WIDTH = 900.0
# The contact counts as sliding as a whole where |Q| is this near to f P, over f P: P may vary
# within a step.
_LIMIT_TOLERANCE = 1e-6
# Slip of the middle below this counts as none, over the stroke of the actuator.
_LEAST_SLIDE = 1e-6
# Two half-widths that differ by less, over one of them, are the same.
_WIDTH_TOLERANCE = 1e-9


class Motion(enum.IntEnum):
    """What a contact does between two instants."""

    APART = 0
    STICK = 1
    PARTIAL = 2
    FORWARD = 3
    BACK = 4


_CSS_AND_WORDS = {
    Motion.APART: ("state-0", "apart"),
    Motion.STICK: ("state-1", "sticks"),
    Motion.PARTIAL: ("pale-stick", "partial slip"),
    Motion.FORWARD: ("pale-forward", "slides forward as a whole"),
    Motion.BACK: ("pale-reverse", "slides back as a whole"),
}


@dataclass(frozen=True, eq=False)
class RigMotion:
    """What a rig and its contact do under a prescribed displacement, at k instants: those of the
    last cycle, or of the whole path where nothing repeats.

    Attributes
    ----------
    scene
        as stated, with displacements of the actuator
    solution
        under the loads that follow from them, by theory or by finite elements
    inputs
        uncertainties that those of the inputs give to the solution; None where none is stated
    solution_by_elements
        that of finite elements where `solution` is theory's; None where they were not solved
    """

    scene: Scene
    solution: ContactSolution
    inputs: InputEffects | None = None
    solution_by_elements: ContactSolution | None = None

    @cached_property
    def motion_by_elements(self) -> RigMotion | None:
        """What the rig does by finite elements, where they were solved beside theory; else None."""
        if self.solution_by_elements is None:
            return None
        return RigMotion(self.scene, self.solution_by_elements)

    @property
    def part_of_path(self) -> str:
        """Which part of the path is shown: the "last cycle" or the "path"."""
        return "path" if self.solution.scene.load.path().period is None else "last cycle"

    @cached_property
    def instants(self) -> Indices:
        """(k,) indices of the instants that are shown."""
        return self.solution.last_cycle

    @property
    def time(self) -> Array:
        """Times of the instants, (k,)."""
        return self.solution.time[self.instants]

    @property
    def normal_load(self) -> Array:
        """P, (k,)."""
        return self.solution.normal_load[self.instants]

    @property
    def tangential_load(self) -> Array:
        """Q, (k,)."""
        return self.solution.tangential_load[self.instants]

    @property
    def actuator_displacement(self) -> Array:
        """Displacement U_act of the actuator, (k,) [length]."""
        return np.asarray(self.scene.load.path_of_actuators().at(self.time)[1])

    @property
    def contact_displacement(self) -> Array:
        """Displacement U of the contact, (k,) [length]: U = U_act - Q/k_s, k_s the stiffness of a
        spring between actuator and bodies.
        """
        stiffness = self.scene.rig.tangential_stiffness
        if stiffness is None:
            return self.actuator_displacement
        return np.asarray(self.actuator_displacement - self.tangential_load / stiffness)

    @cached_property
    def motions(self) -> Indices:
        """What the contact does in the step that ends at each instant, (k,), by the codes of
        `Motion`: stick, partial slip, sliding forward or back, apart. The first instant, which ends
        no step, has that of its own state.

        The stick half-width of the solution is NaN where no part of the contact sticks. Tolerances:
        1e-6 of f P, and 1e-9 of the contact half-width.
        """
        normal_load = self.normal_load  # (k,), of the shown instants
        tangential_load = self.tangential_load
        stick_half_width = self.solution.stick_half_width[self.instants]
        contact_half_width = self.solution.contact_half_width[self.instants]
        is_apart = normal_load <= 0
        coulomb_limit = self.scene.friction.coefficient * normal_load
        is_at_limit = np.abs(tangential_load) >= coulomb_limit * (1 - _LIMIT_TOLERANCE)
        # no stick zone, and all of f P is used: the bodies slide as a whole
        is_sliding = ~is_apart & np.isnan(stick_half_width) & is_at_limit
        slide_direction = np.where(is_sliding, np.sign(tangential_load), 0)
        is_sticking = stick_half_width >= contact_half_width * (1 - _WIDTH_TOLERANCE)

        # In a step the contact sticks where it sticks at its end and did not slide at its start; it
        # slides where it does so at both.
        index_before = np.maximum(np.arange(len(normal_load)) - 1, 0)
        direction_before = slide_direction[index_before]
        motion_codes = np.full(len(normal_load), Motion.PARTIAL, dtype=np.int64)
        motion_codes[is_sticking & (direction_before == 0)] = Motion.STICK
        motion_codes[(slide_direction > 0) & (direction_before > 0)] = Motion.FORWARD
        motion_codes[(slide_direction < 0) & (direction_before < 0)] = Motion.BACK
        motion_codes[is_apart | is_apart[index_before]] = Motion.APART
        return motion_codes

    @cached_property
    def slip_of_middle(self) -> Array:
        """Slip of the middle of the contact since the first instant, (k,) [length]. It changes
        where the bodies slide as a whole, and where they are moved while apart.
        """
        middle_point = int(np.argmin(np.abs(self.solution.x)))
        slip = self.solution.slip[self.instants, middle_point]
        return np.asarray(slip - slip[0])

    def time_fraction(self, kind_of_motion: Motion) -> float:
        """Time with that motion over the whole time."""
        duration = np.diff(self.time)
        return float(np.sum(duration[self.motions[1:] == kind_of_motion]) / np.sum(duration))

    def slide_distance(self, kind_of_motion: Motion) -> float:
        """Distance that the middle of the contact slips in that motion [length], never negative."""
        slips_in_steps = np.abs(np.diff(self.slip_of_middle))
        return float(np.sum(slips_in_steps[self.motions[1:] == kind_of_motion]))

    def intervals(self) -> Iterator[tuple[Motion, float, float]]:
        """What the contact does, such as stick or partial slip, one kind of motion after the other:
        each with the times at which it begins and ends.

        `motions` (k,) is a code for the motion in the step that ends at each of k instants; no step
        ends at the first.
        """
        motion_codes = self.motions[1:]
        # indices of the instants at which a motion begins and ends
        changes = np.flatnonzero(np.diff(motion_codes)) + 1
        first_indices = [0, *changes.tolist()]
        last_indices = [*changes.tolist(), len(motion_codes)]
        for first_index, last_index in zip(first_indices, last_indices, strict=True):
            yield (
                Motion(int(motion_codes[first_index])),
                float(self.time[first_index]),
                float(self.time[last_index]),
            )


# ------------------------------------------------------------------------------------------ figures
def _loop(rig_motion: RigMotion) -> Plate:
    """A figure of the tangential load Q over the displacement U of the contact, and over that of
    the actuator where a spring is between. Finite elements are drawn too where they were solved.
    Its width is 900 pixels.

    `rig_motion` holds loads and displacements (k,) at the shown instants; `motion_by_elements`
    those by finite elements beside theory, or None.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.
    """
    _, unit_of_length, _ = units(rig_motion.scene)
    unit_of_load = load_unit(rig_motion.scene)
    rig_motions = [rig_motion]
    if rig_motion.motion_by_elements is not None:
        rig_motions.append(rig_motion.motion_by_elements)
    table: dict[str, list[Any]] = {"engine": []}
    for motion_by_engine in rig_motions:
        engine_name = engine_in_words(motion_by_engine.solution.engine)
        table["engine"] += [engine_name] * len(motion_by_engine.time)
    # heading of a column, and the attribute of a rig's motion that it holds
    for column, attribute in (
        ("time", "time"),
        (f"P [{unit_of_load}]", "normal_load"),
        (f"Q [{unit_of_load}]", "tangential_load"),
        (f"U of the contact [{unit_of_length}]", "contact_displacement"),
        (f"U of the actuator [{unit_of_length}]", "actuator_displacement"),
    ):
        values_by_engine = [getattr(by_engine, attribute) for by_engine in rig_motions]
        table[column] = np.concatenate(values_by_engine).tolist()
    panel = _loop_panel(rig_motion, "rig-loop", _WIDTH, 380.0)
    return figure_with_texts(
        "rig_loop",
        [panel],
        table,
        _keys_of_loops([rig_motion]),
        n_columns=1,
        noun=rig_motion.part_of_path,
        has_spring=rig_motion.scene.rig.tangential_stiffness is not None,
    )


# entries of the legend for the loop over the displacement of the contact, of the actuator, and of
# the contact by finite elements
_KEYS_OF_LOOP = (Key("c0 bold", "contact"), Key("c1 dash", "actuator"))
_KEY_OF_ELEMENTS = Key("c2 dash", "contact, finite elements")


def _keys_of_loops(rig_motions: Sequence[RigMotion]) -> tuple[Key, ...]:
    """Entries of the legend for the loops of these rigs: those of the contact, of the actuator
    where a rig has a spring, and by finite elements where they were solved beside theory.
    """
    have_spring = any(
        rig_motion.scene.rig.tangential_stiffness is not None for rig_motion in rig_motions
    )
    keys = _KEYS_OF_LOOP if have_spring else _KEYS_OF_LOOP[:1]
    if any(rig_motion.motion_by_elements is not None for rig_motion in rig_motions):
        keys = (*keys, _KEY_OF_ELEMENTS)
    return keys


def _loop_panel(
    rig_motion: RigMotion, name: str, width: float, height: float, title: str = ""
) -> Panel:
    """A panel of Q over the displacement U of the contact, and over that of the actuator where a
    spring is between. Finite elements are drawn too where they were solved. `width` and `height`
    are in pixels; `name` is that of the panel on the page. `rig_motion` holds loads and
    displacements (k,) at the shown instants.

    `Rule` is a line across the panel. `css` is a class of the style sheet.
    """
    key_of_contact, key_of_actuator = _KEYS_OF_LOOP  # entries of the legend
    tangential_load = rig_motion.tangential_load
    # (displacement, load, entry of the legend) of each loop
    drawn_loops = [(rig_motion.contact_displacement, tangential_load, key_of_contact)]
    if rig_motion.scene.rig.tangential_stiffness is not None:
        drawn_loops.append((rig_motion.actuator_displacement, tangential_load, key_of_actuator))
    motion_by_elements = rig_motion.motion_by_elements
    if motion_by_elements is not None:
        drawn_loops.append(
            (
                motion_by_elements.contact_displacement,
                motion_by_elements.tangential_load,
                _KEY_OF_ELEMENTS,
            )
        )
    curves = [
        Curve(displacement, load, key.css, key.text) for displacement, load, key in drawn_loops
    ]
    x_limits = axis_limits(*(curve.x for curve in curves))
    _, unit_of_length, _ = units(rig_motion.scene)
    return Panel(
        name,
        Axis(*x_limits, f"displacement U  [{unit_of_length}]"),
        Axis(*axis_limits(*(curve.y for curve in curves)), f"Q  [{load_unit(rig_motion.scene)}]"),
        [Rule(0.0, "zero"), *curves],
        "Loop of the tangential load over the displacement",
        width,
        height,
        title=title,
        css="broad",
    )


def loops(rig_motions: Sequence[RigMotion]) -> Plate:
    """A figure of the loops of the tangential load Q, a panel for each of several rigs, two beside
    each other. Each has Q over the displacement U of the contact, and over that of the actuator
    where a spring is between; finite elements are drawn too where they were solved beside theory.
    The figure's table holds the loop of the contact alone, not that by finite elements.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV.
    `rig_motions` hold loads and displacements (k,) of each rig at its shown instants.
    """
    panels = []
    panel_width, panel_height = 440.0, 300.0  # pixels
    table: dict[str, list[Any]] = {"scene": [], "U of the contact": [], "Q": []}
    for rig_motion in rig_motions:
        name = rig_motion.scene.name
        panels.append(_loop_panel(rig_motion, f"loop-{name}", panel_width, panel_height, name))
        table["scene"] += [name] * len(rig_motion.time)
        table["U of the contact"] += rig_motion.contact_displacement.tolist()
        table["Q"] += rig_motion.tangential_load.tolist()
    return figure_with_texts("rig_loops", panels, table, _keys_of_loops(rig_motions))


def _over_time(rig_motion: RigMotion) -> Plate:
    """A figure of a rig over time in two panels. The upper one has Q between the Coulomb limits
    ±f P, on colours that show what the contact does. The lower one has the displacements of
    actuator and contact, and the slip of the middle of the contact since the first instant, with
    its sign: it changes where the bodies slide as a whole, and where they are moved while apart.

    `rig_motion` holds time, loads, displacements and slip of the middle (k,) at the shown instants,
    and what the contact does (stick, partial slip, ...) with the times between which it does so.

    A `Plate` is a figure: panels, legend, caption, and the table of its numbers for a CSV. `Key` is
    an entry of the legend.
    """
    displacement_curves = _curves_of_displacement(rig_motion)
    panels = [
        _panel_of_force(rig_motion),
        _panel_of_displacement(rig_motion, displacement_curves),
    ]
    keys = [Key("c5 bold", "Q"), Key("cone", "±f P")]
    keys += [Key(curve.css, curve.label) for curve in displacement_curves]
    # `_CSS_AND_WORDS`: class of the style sheet, and words, of a kind of motion, such as stick
    drawn_kinds = {kind_of_motion for kind_of_motion, _, _ in rig_motion.intervals()}
    keys += [
        Key(*_CSS_AND_WORDS[kind_of_motion], is_patch=True)
        for kind_of_motion in Motion
        if kind_of_motion in drawn_kinds
    ]
    # `noun`: "last cycle" or "path", for the caption
    return figure_with_texts(
        "rig_over_time",
        panels,
        _table_over_time(rig_motion),
        keys,
        n_columns=1,
        noun=rig_motion.part_of_path,
    )


def _panel_over_time(
    rig_motion: RigMotion, name: str, y_axis: Axis, marks: Sequence[Mark], alt: str
) -> Panel:
    """A panel over the times of the shown instants, 900 pixels wide. `name` is that of the panel on
    the page; `alt` says what it shows, for readers who can't see it.
    """
    time_axis = Axis(float(rig_motion.time[0]), float(rig_motion.time[-1]), "time")
    return Panel(name, time_axis, y_axis, marks, alt, _WIDTH, 300.0, css="broad", time="x")


def _panel_of_force(rig_motion: RigMotion) -> Panel:
    """A panel of the tangential load Q of a rig over time, between the Coulomb limits ±f P.
    Rectangles behind the curves show by colour what the contact does: stick, partial slip, sliding
    forward or back as a whole, apart.

    `rig_motion` holds times and loads (k,) at the shown instants, and the intervals of each kind of
    motion.
    """
    time = rig_motion.time
    coulomb_limit = rig_motion.scene.friction.coefficient * rig_motion.normal_load
    force_range = axis_limits(coulomb_limit, -coulomb_limit)
    # `_CSS_AND_WORDS`: class of the style sheet, and words, of a kind of motion
    marks: list[Mark] = [
        Block((begin, end), force_range, _CSS_AND_WORDS[kind_of_motion][0])
        for kind_of_motion, begin, end in rig_motion.intervals()
    ]
    marks += [
        Curve(time, coulomb_limit, "cone", "f P"),
        Curve(time, -coulomb_limit, "cone", "−f P"),
        Curve(time, rig_motion.tangential_load, "c5 bold", "Q"),
    ]
    y_axis = Axis(*force_range, f"Q  [{load_unit(rig_motion.scene)}]")
    return _panel_over_time(rig_motion, "rig-force", y_axis, marks, "Q over time")


def _curves_of_displacement(rig_motion: RigMotion) -> list[Curve]:
    """Curves over time of the displacement of the actuator, of that of the contact, and of the slip
    of the middle of the contact since the first instant [length].
    """
    time = rig_motion.time
    return [
        Curve(time, rig_motion.actuator_displacement, "c1 dash", "U of the actuator"),
        Curve(time, rig_motion.contact_displacement, "c0", "U of the contact"),
        Curve(time, rig_motion.slip_of_middle, "c2 bold", "way that the bodies slide"),
    ]


def _panel_of_displacement(rig_motion: RigMotion, curves: Sequence[Curve]) -> Panel:
    """A panel over time with `curves` of displacements [length] and a line at zero; its axis holds
    all of them.
    """
    _, unit_of_length, _ = units(rig_motion.scene)
    y_limits = axis_limits(*(curve.y for curve in curves))
    y_axis = Axis(*y_limits, f"displacement  [{unit_of_length}]")
    marks: list[Mark] = [Rule(0.0, "zero"), *curves]
    return _panel_over_time(rig_motion, "rig-way", y_axis, marks, "Displacements over time")


def _table_over_time(rig_motion: RigMotion) -> Table:
    """Columns of a CSV file on a rig, (k,) each for its k shown instants: time; tangential load Q;
    its limit f P at gross sliding; slip at the middle of the contact; and the motion in words.

    `rig_motion` has these by one engine, and `normal_load` P. `motions` (k,) is a code for the
    motion of the contact in the step that ends at each instant, such as stick or partial slip;
    `_CSS_AND_WORDS` gives the words for it. The middle slips only where the bodies slide as a
    whole.

    # notation: f coefficient of friction
    """
    _, unit_of_length, _ = units(rig_motion.scene)
    unit_of_load = load_unit(rig_motion.scene)
    words_of_motions = []
    for code in rig_motion.motions.tolist():
        _, words_of_motion = _CSS_AND_WORDS[Motion(code)]
        words_of_motions.append(words_of_motion)
    coulomb_limit = rig_motion.scene.friction.coefficient * rig_motion.normal_load
    return {
        "time": rig_motion.time,
        f"Q [{unit_of_load}]": rig_motion.tangential_load,
        f"f P [{unit_of_load}]": coulomb_limit,
        f"way that the bodies slide [{unit_of_length}]": rig_motion.slip_of_middle,
        "motion in the step before": words_of_motions,
    }


# ------------------------------------------------------------------------------------------ numbers
def rows_of(rig_motion: RigMotion) -> list[tuple[str, str]]:
    """Rows (label with unit, value) of the first table of a rig: strokes (largest minus least
    displacement), loads, dissipation, and how long the contact sticks or slides. Finite elements
    have rows at the end where they were solved beside theory.

    `rig_motion` holds loads and displacements (k,) at the shown instants. `part_of_path` is "last
    cycle" or "path".
    """
    scene = rig_motion.scene
    _, unit_of_length, _ = units(scene)
    unit_of_load = load_unit(scene)
    actuator_stroke = np.ptp(rig_motion.actuator_displacement)
    contact_stroke = np.ptp(rig_motion.contact_displacement)
    least_normal_load = float(np.min(rig_motion.normal_load))
    largest_normal_load = float(np.max(rig_motion.normal_load))
    normal_in_words = f"{least_normal_load:.6g} to {largest_normal_load:.6g}"
    if least_normal_load == largest_normal_load:
        normal_in_words = f"{largest_normal_load:.6g}"
    least_tangential_load = np.min(rig_motion.tangential_load)
    largest_tangential_load = np.max(rig_motion.tangential_load)
    # `minus`: with a real minus sign
    rows = [
        (f"stroke of the actuator [{unit_of_length}]", f"{actuator_stroke:.6g}"),
        (f"stroke of the contact [{unit_of_length}]", f"{contact_stroke:.6g}"),
        (f"P [{unit_of_load}]", normal_in_words),
        (
            f"Q [{unit_of_load}]",
            minus(f"{least_tangential_load:.6g} to {largest_tangential_load:.6g}"),
        ),
    ]
    if scene.friction.coefficient:
        rows.append(row_of_sliding(rig_motion.solution))
    label_of_work = f"dissipation W of the {rig_motion.part_of_path} [{energy_unit(scene)}]"
    rows.append((label_of_work, f"{rig_motion.solution.dissipation:.6g}"))
    rows += _rows_of_motions(rig_motion)
    if rig_motion.motion_by_elements is not None:
        rows += _rows_of_elements(rig_motion, rig_motion.motion_by_elements)
    return rows


def _rows_of_motions(rig_motion: RigMotion) -> Iterator[tuple[str, str]]:
    """Rows (kind of motion, value) on what the contact of a rig does: for each kind of motion that
    occurs, such as stick or partial slip, the part of the time in it. Where the bodies slide
    forward or back as a whole, the distance follows.

    `rig_motion` states, for a kind of motion, the fraction of the time in it and the distance slid.
    """
    _, unit_of_length, _ = units(rig_motion.scene)
    for kind_of_motion in Motion:
        time_fraction = rig_motion.time_fraction(kind_of_motion)
        if not time_fraction:
            continue
        time_in_words = f"{100 * time_fraction:.3g} % of the time"
        if kind_of_motion in (Motion.FORWARD, Motion.BACK):
            time_in_words += (
                f", over {rig_motion.slide_distance(kind_of_motion):.6g} {unit_of_length}"
            )
        # _CSS_AND_WORDS: for each kind of motion the class of the style sheet, and words
        _, words_of_motion = _CSS_AND_WORDS[kind_of_motion]
        yield words_of_motion, time_in_words


def _rows_of_elements(by_theory: RigMotion, by_elements: RigMotion) -> list[tuple[str, str]]:
    """Rows (label with unit, value) on a rig by finite elements: dissipation with its difference
    from theory's, range of Q, and the sliding distance where the bodies slide as a whole: where it
    is more than 1e-6 of the stroke of the actuator.

    `by_theory` and `by_elements` are the motion of the rig by each engine.
    """
    unit_of_load = load_unit(by_theory.scene)
    _, unit_of_length, _ = units(by_theory.scene)
    dissipation = by_elements.solution.dissipation
    dissipation_of_theory = by_theory.solution.dissipation
    uncertainty = getattr(by_elements.solution, "dissipation_uncertainty", math.nan)
    work_in_words = f"{dissipation:.6g}"
    if math.isfinite(uncertainty):
        work_in_words += f" ± {uncertainty:.1g}"
    if dissipation_of_theory:
        work_in_words += f" ({100 * (dissipation / dissipation_of_theory - 1):+.3g} %)"
    tangential_load = by_elements.tangential_load
    # `minus`: with a real minus sign
    rows = [
        (f"W by finite elements [{energy_unit(by_theory.scene)}]", minus(work_in_words)),
        (
            f"Q by finite elements [{unit_of_load}]",
            minus(f"{np.min(tangential_load):.6g} to {np.max(tangential_load):.6g}"),
        ),
    ]
    # Sliding may begin within an increment, which `motions` does not count as sliding. The middle
    # of the contact is the last to slip, so its slip is all of the sliding.
    sliding_distance = float(np.sum(np.abs(np.diff(by_elements.slip_of_middle))))
    if sliding_distance > _LEAST_SLIDE * float(np.ptp(by_elements.actuator_displacement)):
        rows.append((f"slide by finite elements [{unit_of_length}]", f"{sliding_distance:.6g}"))
    return rows


def may_slide(rig_motion: RigMotion) -> bool:
    """Whether bodies that do not slide as a whole may do so by the uncertainty of the inputs."""
    if rig_motion.inputs is None or rig_motion.inputs.sliding is None:
        return False
    return rig_motion.inputs.sliding.is_in_reach


def _sentence(rig_motion: RigMotion) -> str:
    """The first sentences on a rig: whether the bodies slide as a whole and how far, and the
    dissipation W. Where they do not slide, the uncertainties of the inputs may allow it. The middle
    of the contact slips only while all of it slides; `slide_distance` is the distance that it slips
    in a motion.

    `rig_motion` holds the solution, and what the contact does at the shown instants.
    """
    _, unit_of_length, _ = units(rig_motion.scene)
    part_of_path = rig_motion.part_of_path
    forward_distance = rig_motion.slide_distance(Motion.FORWARD)
    sliding_distance = forward_distance + rig_motion.slide_distance(Motion.BACK)
    if sliding_distance:
        sentence_on_sliding = (
            f"The bodies slide as a whole by {sliding_distance:.6g} {unit_of_length} in the"
            f" {part_of_path}."
        )
    elif may_slide(rig_motion):
        sentence_on_sliding = (
            f"Nothing slides as a whole in the {part_of_path}, but with these inputs the bodies"
            " may."
        )
    else:
        sentence_on_sliding = f"Nothing slides as a whole in the {part_of_path}."
    dissipation = rig_motion.solution.dissipation
    return f"{sentence_on_sliding} W = {dissipation:.6g} {energy_unit(rig_motion.scene)}."


def _notes_of(rig_motion: RigMotion) -> Iterator[str]:
    """Notes of theory's solution and of the finite elements' for a rig."""
    yield from rig_motion.solution.record.notes
    if rig_motion.solution_by_elements is not None:
        for note in rig_motion.solution_by_elements.record.notes:
            yield f"finite elements: {note}"


def write(rig_motion: RigMotion, out: str | Path, command: str, remarks: Sequence[str]) -> Path:
    """Write the page of a rig and the CSV of each figure to the folder `out`, which holds the
    solutions. Returns the path of the page. `remarks` are sentences on which engines can solve the
    scene.
    """
    page_script, script_hash = script()  # and its digest, by which a browser knows it
    plates = (_loop(rig_motion), _over_time(rig_motion))
    summary = summary_rows(rig_motion.solution)  # (label, value) on the solution
    # a temporary folder, whose files move to `out` at the end; pages of an earlier run are removed
    with results_folder(out, stale_prefixes=("report.html", "figures/")) as folder:
        write_tables(plates, folder)
        page_text = template("rig.html").render(
            title=rig_motion.scene.title or rig_motion.scene.name,
            scene=rig_motion.scene,
            sentence=_sentence(rig_motion),
            is_open=may_slide(rig_motion),
            rows=rows_of(rig_motion),
            summary=[row for row in summary if row[0] != "note"],
            notes=(*_notes_of(rig_motion), *remarks),
            drawings=plates,
            inputs=rig_motion.inputs,
            input_words=input_words,
            command=command,
            script=page_script,
            script_hash=script_hash,
        )
        (folder / "report.html").write_text(page_text, encoding="utf-8")
    return Path(out) / "report.html"
