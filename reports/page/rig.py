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
    figure_with_texts,
    limits,
    write_tables,
)
from reports.charts.templating import Table, script, template
from reports.comparison.pairs import name_of
from reports.comparison.words import row_of_sliding, summary_rows
from reports.folder import filled
from reports.inputs import InputEffects
from reports.units import energy_unit, load_unit, minus, units
from scenes import ContactSolution, Scene
from scenes.array_types import Array, Indices

_WIDTH = 900.0
# Share of f P from which on the contact counts as sliding as a whole, where P varies within a step.
_AT_LIMIT = 1e-6
# Share of the stroke below which slip of the middle is none.
_NO_SLIDE = 1e-6
# Share of a half-width within which two are the same.
_SAME = 1e-9


class Motion(enum.IntEnum):
    """What a contact does between two instants."""

    APART = 0
    STICK = 1
    PARTIAL = 2
    FORWARD = 3
    BACK = 4


_MOTIONS = {
    Motion.APART: ("state-0", "apart"),
    Motion.STICK: ("state-1", "sticks"),
    Motion.PARTIAL: ("pale-stick", "partial slip"),
    Motion.FORWARD: ("pale-forward", "slides forward as a whole"),
    Motion.BACK: ("pale-reverse", "slides back as a whole"),
}


@dataclass(frozen=True, eq=False)
class RigMotion:
    """What a rig and its contact do in the last cycle, or on the path where there is none.

    Attributes
    ----------
    scene
        as stated, with displacements
    solution
        under the loads that follow from them
    inputs
        what the stated uncertainties of the inputs make of the answer; None where none is stated
    beside
        the finite elements' answer where `solution` is theory's; None without one
    """

    scene: Scene
    solution: ContactSolution
    inputs: InputEffects | None = None
    beside: ContactSolution | None = None

    @cached_property
    def elements(self) -> RigMotion | None:
        """What the rig does by finite elements, where they were solved beside theory; else None."""
        return RigMotion(self.scene, self.beside) if self.beside is not None else None

    @property
    def noun(self) -> str:
        """Which part of the path is shown: the "last cycle" or the "path"."""
        return "path" if self.solution.scene.load.path().period is None else "last cycle"

    @cached_property
    def rows(self) -> Indices:
        """(k,) steps that are shown."""
        return self.solution.last_cycle

    @property
    def time(self) -> Array:
        """(k,) instants."""
        return self.solution.time[self.rows]

    @property
    def normal_load(self) -> Array:
        """P, (k,)."""
        return self.solution.normal_load[self.rows]

    @property
    def tangential_load(self) -> Array:
        """Q, (k,)."""
        return self.solution.tangential_load[self.rows]

    @property
    def actuator(self) -> Array:
        """U_act, (k,) [length]."""
        return np.asarray(self.scene.load.path_of_actuators().at(self.time)[1])

    @property
    def contact(self) -> Array:
        """U of the contact, (k,) [length]: that of the actuator without the spring."""
        stiffness = self.scene.rig.tangential_stiffness
        if stiffness is None:
            return self.actuator
        return np.asarray(self.actuator - self.tangential_load / stiffness)

    @cached_property
    def motions(self) -> Indices:
        """What the contact does in the step that ends at each instant, (k,), by the codes of
        `Motion`: stick, partial slip, sliding forward or back, apart. The first instant, which ends
        no step, has that of its own state.
        """
        normal_load = self.normal_load
        tangential_load = self.tangential_load
        stick_half_width = self.solution.stick_half_width[self.rows]
        contact_half_width = self.solution.contact_half_width[self.rows]
        is_apart = normal_load <= 0
        limit = self.scene.friction.coefficient * normal_load * (1 - _AT_LIMIT)
        # no stick zone, and all of f P is used: the bodies slide as a whole
        slide_direction = np.where(
            ~is_apart & np.isnan(stick_half_width) & (np.abs(tangential_load) >= limit),
            np.sign(tangential_load),
            0,
        )
        sticks = stick_half_width >= contact_half_width * (1 - _SAME)
        motions = np.full(len(normal_load), Motion.PARTIAL, dtype=np.int64)
        row_before = np.maximum(np.arange(len(normal_load)) - 1, 0)
        motions[sticks & (slide_direction[row_before] == 0)] = Motion.STICK
        motions[(slide_direction > 0) & (slide_direction[row_before] > 0)] = Motion.FORWARD
        motions[(slide_direction < 0) & (slide_direction[row_before] < 0)] = Motion.BACK
        motions[is_apart | is_apart[row_before]] = Motion.APART
        return motions

    @cached_property
    def way(self) -> Array:
        """Slip of the middle of the contact since the first instant, (k,) [length]: where it moves,
        the bodies slide as a whole.
        """
        middle = int(np.argmin(np.abs(self.solution.x)))
        slip = self.solution.slip[self.rows, middle]
        return np.asarray(slip - slip[0])

    def share(self, motion: Motion) -> float:
        """Share of the time with that motion."""
        duration = np.diff(self.time)
        return float(np.sum(duration[self.motions[1:] == motion]) / np.sum(duration))

    def distance(self, motion: Motion) -> float:
        """Way of the middle of the contact in that motion, whatever its sign [length]."""
        steps = np.abs(np.diff(self.way))
        return float(np.sum(steps[self.motions[1:] == motion]))

    def stretches(self) -> Iterator[tuple[Motion, float, float]]:
        """Each motion with the instants between which it lasts."""
        motions = self.motions[1:]
        changes = np.flatnonzero(np.diff(motions)) + 1
        begins = [0, *changes.tolist()]
        ends = [*changes.tolist(), len(motions)]
        for begin, end in zip(begins, ends, strict=True):
            yield Motion(int(motions[begin])), float(self.time[begin]), float(self.time[end])


# ------------------------------------------------------------------------------------------ figures
def _loop(rig: RigMotion) -> Plate:
    """A figure of the tangential load Q over the displacement of the contact; over that of the
    actuator too where a spring is between. `rig` holds the solved motion under a prescribed
    displacement.
    """
    unit_of_length = units(rig.scene)[1]
    unit_of_load = load_unit(rig.scene)
    motions = [motion for motion in (rig, rig.elements) if motion is not None]
    columns: dict[str, list[Any]] = {"engine": []}
    for motion in motions:
        columns["engine"] += [_engine(motion)] * len(motion.time)
    for name, values in (
        ("time", [motion.time for motion in motions]),
        (f"P [{unit_of_load}]", [motion.normal_load for motion in motions]),
        (f"Q [{unit_of_load}]", [motion.tangential_load for motion in motions]),
        (f"U of the contact [{unit_of_length}]", [motion.contact for motion in motions]),
        (f"U of the actuator [{unit_of_length}]", [motion.actuator for motion in motions]),
    ):
        columns[name] = np.concatenate(values).tolist()
    has_spring = rig.scene.rig.tangential_stiffness is not None
    keys = _KEYS_OF_LOOP if has_spring else _KEYS_OF_LOOP[:1]
    if rig.elements is not None:
        keys = (*keys, _KEY_OF_ELEMENTS)
    panel = _loop_panel(rig, "rig-loop", _WIDTH, 380.0)
    return figure_with_texts(
        "rig_loop", [panel], columns, keys, columns=1, noun=rig.noun, has_spring=has_spring
    )


_KEYS_OF_LOOP = (Key("c0 bold", "contact"), Key("c1 dash", "actuator"))
_KEY_OF_ELEMENTS = Key("c2 dash", "contact, finite elements")


def _engine(rig: RigMotion) -> str:
    return name_of(rig.solution.engine)


def _loop_panel(rig: RigMotion, name: str, width: float, height: float, title: str = "") -> Panel:
    """A panel of Q over the displacement U through the motion of a rig: U of the contact, and of
    the actuator where a spring is between; by finite elements too where they were solved. `rig`
    holds the solved motion under a prescribed displacement.
    """
    key_of_contact, key_of_actuator = _KEYS_OF_LOOP
    curves = [Curve(rig.contact, rig.tangential_load, key_of_contact.css, key_of_contact.text)]
    if rig.scene.rig.tangential_stiffness is not None:
        curves.append(
            Curve(rig.actuator, rig.tangential_load, key_of_actuator.css, key_of_actuator.text)
        )
    if (elements := rig.elements) is not None:
        key_of_elements = _KEY_OF_ELEMENTS
        curves.append(
            Curve(
                elements.contact,
                elements.tangential_load,
                key_of_elements.css,
                key_of_elements.text,
            )
        )
    x_limits = limits(*(curve.x for curve in curves))
    return Panel(
        name,
        Axis(*x_limits, f"displacement U  [{units(rig.scene)[1]}]"),
        Axis(*limits(*(curve.y for curve in curves)), f"Q  [{load_unit(rig.scene)}]"),
        [Rule(0.0, "zero"), *curves],
        "Loop of the tangential load over the displacement",
        width,
        height,
        title=title,
        css="broad",
    )


def loops(rigs: Sequence[RigMotion]) -> Plate:
    """Loops of several rigs, two beside each other."""
    panels = [
        _loop_panel(rig, f"loop-{rig.scene.name}", 440.0, 300.0, rig.scene.name) for rig in rigs
    ]
    columns: dict[str, list[Any]] = {"scene": [], "U of the contact": [], "Q": []}
    for rig in rigs:
        columns["scene"] += [rig.scene.name] * len(rig.time)
        columns["U of the contact"] += rig.contact.tolist()
        columns["Q"] += rig.tangential_load.tolist()
    return figure_with_texts("rig_loops", panels, columns, _KEYS_OF_LOOP)


def _over_time(rig: RigMotion) -> Plate:
    """A figure of a rig over time in two panels. The upper one has Q between the limits of
    friction, on colours that show what the contact does. The lower one has the displacements of
    actuator and contact, and the distance that the bodies slide. `rig` holds the solved motion
    under a prescribed displacement.
    """
    unit_of_length = units(rig.scene)[1]
    unit_of_load = load_unit(rig.scene)
    friction_limit = rig.scene.friction.coefficient * rig.normal_load
    force_range = limits(friction_limit, -friction_limit)
    force_marks: list[Mark] = [
        Block((begin, end), force_range, _MOTIONS[motion][0])
        for motion, begin, end in rig.stretches()
    ]
    force_marks += [
        Curve(rig.time, friction_limit, "cone", "f P"),
        Curve(rig.time, -friction_limit, "cone", "−f P"),
        Curve(rig.time, rig.tangential_load, "c5 bold", "Q"),
    ]
    displacement_curves = [
        Curve(rig.time, rig.actuator, "c1 dash", "U of the actuator"),
        Curve(rig.time, rig.contact, "c0", "U of the contact"),
        Curve(rig.time, rig.way, "c2 bold", "way that the bodies slide"),
    ]
    time_axis = Axis(float(rig.time[0]), float(rig.time[-1]), "time")

    def panel_of(name: str, y_axis: Axis, marks: Sequence[Mark], alt: str) -> Panel:
        return Panel(name, time_axis, y_axis, marks, alt, _WIDTH, 300.0, css="broad", time="x")

    panels = [
        panel_of(
            "rig-force", Axis(*force_range, f"Q  [{unit_of_load}]"), force_marks, "Q over time"
        ),
        panel_of(
            "rig-way",
            Axis(
                *limits(*(curve.y for curve in displacement_curves)),
                f"displacement  [{unit_of_length}]",
            ),
            [Rule(0.0, "zero"), *displacement_curves],
            "Displacements over time",
        ),
    ]
    keys = [Key("c5 bold", "Q"), Key("cone", "±f P")]
    keys += [Key(curve.css, curve.label) for curve in displacement_curves]
    motions_shown = {motion for motion, _, _ in rig.stretches()}
    keys += [Key(*_MOTIONS[motion], patch=True) for motion in Motion if motion in motions_shown]
    columns: Table = {
        "time": rig.time,
        f"Q [{unit_of_load}]": rig.tangential_load,
        f"f P [{unit_of_load}]": friction_limit,
        f"way that the bodies slide [{unit_of_length}]": rig.way,
        "motion in the step before": [_MOTIONS[Motion(code)][1] for code in rig.motions.tolist()],
    }
    return figure_with_texts("rig_over_time", panels, columns, keys, columns=1, noun=rig.noun)


# ------------------------------------------------------------------------------------------ numbers
def rows_of(rig: RigMotion) -> list[tuple[str, str]]:
    """Rows (label with unit, value) of the first table of a rig: strokes, loads, dissipation, and
    how long the contact sticks or slides. `rig` holds the solved motion under a prescribed
    displacement.
    """
    unit_of_length = units(rig.scene)[1]
    unit_of_load = load_unit(rig.scene)
    dissipation = rig.solution.dissipation
    least_load = float(np.min(rig.normal_load))
    largest_load = float(np.max(rig.normal_load))
    loads = f"{least_load:.6g} to {largest_load:.6g}"
    rows = [
        (f"stroke of the actuator [{unit_of_length}]", f"{np.ptp(rig.actuator):.6g}"),
        (f"stroke of the contact [{unit_of_length}]", f"{np.ptp(rig.contact):.6g}"),
        (f"P [{unit_of_load}]", f"{largest_load:.6g}" if least_load == largest_load else loads),
        (
            f"Q [{unit_of_load}]",
            minus(f"{np.min(rig.tangential_load):.6g} to {np.max(rig.tangential_load):.6g}"),
        ),
        *([row_of_sliding(rig.solution)] if rig.scene.friction.coefficient else []),
        (f"dissipation W of the {rig.noun} [{energy_unit(rig.scene)}]", f"{dissipation:.6g}"),
    ]
    for motion in Motion:
        share_of_time = rig.share(motion)
        if not share_of_time:
            continue
        time_in_words = f"{100 * share_of_time:.3g} % of the time"
        if motion in (Motion.FORWARD, Motion.BACK):
            time_in_words += f", over {rig.distance(motion):.6g} {unit_of_length}"
        rows.append((_MOTIONS[motion][1], time_in_words))
    if rig.elements is not None:
        rows += _rows_of_elements(rig, rig.elements)
    return rows


def _rows_of_elements(rig: RigMotion, elements: RigMotion) -> list[tuple[str, str]]:
    """Rows (label with unit, value) on the finite elements' answer for a rig: dissipation with its
    difference from theory's, range of Q, sliding distance. `rig` holds the solved motion under a
    prescribed displacement.
    """
    unit_of_load = load_unit(rig.scene)
    unit_of_length = units(rig.scene)[1]
    dissipation = elements.solution.dissipation
    uncertainty = getattr(elements.solution, "dissipation_uncertainty", math.nan)
    work_in_words = f"{dissipation:.6g}"
    if math.isfinite(uncertainty):
        work_in_words += f" ± {uncertainty:.1g}"
    if rig.solution.dissipation:
        work_in_words += f" ({100 * (dissipation / rig.solution.dissipation - 1):+.3g} %)"
    tangential_load = elements.tangential_load
    rows = [
        (f"W by finite elements [{energy_unit(rig.scene)}]", minus(work_in_words)),
        (
            f"Q by finite elements [{unit_of_load}]",
            minus(f"{np.min(tangential_load):.6g} to {np.max(tangential_load):.6g}"),
        ),
    ]
    # Of few increments one begins to slide within another: the middle slips only where all do.
    sliding_distance = float(np.sum(np.abs(np.diff(elements.way))))
    if sliding_distance > _NO_SLIDE * float(np.ptp(elements.actuator)):
        rows.append((f"slide by finite elements [{unit_of_length}]", f"{sliding_distance:.6g}"))
    return rows


def may_slide(rig: RigMotion) -> bool:
    """Whether bodies that do not slide as a whole may do so by the uncertainty of the inputs."""
    if rig.inputs is None or rig.inputs.sliding is None:
        return False
    return rig.inputs.sliding.is_in_reach


def _sentence(rig: RigMotion) -> str:
    """The first sentence on a rig: whether the bodies slide as a whole, how far, and the
    dissipation W. `rig` holds the solved motion under a prescribed displacement.
    """
    unit_of_length = units(rig.scene)[1]
    sliding_distance = rig.distance(Motion.FORWARD) + rig.distance(Motion.BACK)
    if sliding_distance:
        sentence_on_slides = (
            f"The bodies slide as a whole by {sliding_distance:.6g} {unit_of_length} in the"
            f" {rig.noun}."
        )
    elif may_slide(rig):
        sentence_on_slides = (
            f"Nothing slides as a whole in the {rig.noun}, but with these inputs the bodies may."
        )
    else:
        sentence_on_slides = f"Nothing slides as a whole in the {rig.noun}."
    return f"{sentence_on_slides} W = {rig.solution.dissipation:.6g} {energy_unit(rig.scene)}."


def _notes_of(rig: RigMotion) -> Iterator[str]:
    """Notes of theory's solution and of the finite elements' for a rig."""
    yield from rig.solution.record.notes
    if rig.beside is not None:
        for note in rig.beside.record.notes:
            yield f"finite elements: {note}"


def write(rig: RigMotion, out: str | Path, command: str, remarks: Sequence[str]) -> Path:
    """Write the page of a rig and the CSV of each figure to the folder that holds the solution;
    returns the path of the page. `remarks` are sentences on which engine takes the scene. `rig`
    holds the solved motion under a prescribed displacement.
    """
    page_script, script_hash = script()
    plates = (_loop(rig), _over_time(rig))
    summary = summary_rows(rig.solution)
    with filled(out, fresh=("report.html", "figures/")) as folder:
        write_tables(plates, folder)
        page = template("rig.html").render(
            title=rig.scene.title or rig.scene.name,
            scene=rig.scene,
            sentence=_sentence(rig),
            is_open=may_slide(rig),
            rows=rows_of(rig),
            summary=[row for row in summary if row[0] != "note"],
            notes=(*_notes_of(rig), *remarks),
            drawings=plates,
            inputs=rig.inputs,
            input_words=input_words,
            command=command,
            script=page_script,
            script_hash=script_hash,
        )
        (folder / "report.html").write_text(page, encoding="utf-8")
    return Path(out) / "report.html"
