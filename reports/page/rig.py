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
    limits,
    worded,
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
        """What the rig does by finite elements, beside theory."""
        return RigMotion(self.scene, self.beside) if self.beside is not None else None

    @property
    def noun(self) -> str:
        """What is shown."""
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
        """`Motion` of the step that ends at each instant, (k,); that of the first one is of no
        step.
        """
        load = self.normal_load
        force = self.tangential_load
        stick = self.solution.stick_half_width[self.rows]
        contact = self.solution.contact_half_width[self.rows]
        is_apart = load <= 0
        limit = self.scene.friction.coefficient * load * (1 - _AT_LIMIT)
        sense = np.where(~is_apart & np.isnan(stick) & (np.abs(force) >= limit), np.sign(force), 0)
        sticks = stick >= contact * (1 - _SAME)
        motions = np.full(len(load), Motion.PARTIAL, dtype=np.int64)
        row_before = np.maximum(np.arange(len(load)) - 1, 0)
        motions[sticks & (sense[row_before] == 0)] = Motion.STICK
        motions[(sense > 0) & (sense[row_before] > 0)] = Motion.FORWARD
        motions[(sense < 0) & (sense[row_before] < 0)] = Motion.BACK
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
    """Q over the displacement of the contact, and of the actuator where a spring is between."""
    length = units(rig.scene)[1]
    load = load_unit(rig.scene)
    answers = [motion for motion in (rig, rig.elements) if motion is not None]
    columns: dict[str, list[Any]] = {"engine": []}
    for answer in answers:
        columns["engine"] += [_engine(answer)] * len(answer.time)
    for name, values in (
        ("time", [answer.time for answer in answers]),
        (f"P [{load}]", [answer.normal_load for answer in answers]),
        (f"Q [{load}]", [answer.tangential_load for answer in answers]),
        (f"U of the contact [{length}]", [answer.contact for answer in answers]),
        (f"U of the actuator [{length}]", [answer.actuator for answer in answers]),
    ):
        columns[name] = np.concatenate(values).tolist()
    has_spring = rig.scene.rig.tangential_stiffness is not None
    keys = _KEYS_OF_LOOP if has_spring else _KEYS_OF_LOOP[:1]
    if rig.elements is not None:
        keys = (*keys, _KEY_OF_ELEMENTS)
    panel = _loop_panel(rig, "rig-loop", _WIDTH, 380.0)
    return worded(
        "rig_loop", [panel], columns, keys, columns=1, noun=rig.noun, has_spring=has_spring
    )


_KEYS_OF_LOOP = (Key("c0 bold", "contact"), Key("c1 dash", "actuator"))
_KEY_OF_ELEMENTS = Key("c2 dash", "contact, finite elements")


def _engine(rig: RigMotion) -> str:
    return name_of(rig.solution.engine)


def _loop_panel(rig: RigMotion, name: str, width: float, height: float, title: str = "") -> Panel:
    """The loop of a rig; that of the actuator too where a spring is between."""
    of_contact, of_actuator = _KEYS_OF_LOOP
    curves = [Curve(rig.contact, rig.tangential_load, of_contact.css, of_contact.text)]
    if rig.scene.rig.tangential_stiffness is not None:
        curves.append(Curve(rig.actuator, rig.tangential_load, of_actuator.css, of_actuator.text))
    if (elements := rig.elements) is not None:
        of_elements = _KEY_OF_ELEMENTS
        curves.append(
            Curve(elements.contact, elements.tangential_load, of_elements.css, of_elements.text)
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
    return worded("rig_loops", panels, columns, _KEYS_OF_LOOP)


def _over_time(rig: RigMotion) -> Plate:
    """Q between the limits of friction over time, above what the contact does; beneath, the
    displacement of actuator and contact, and the way that the bodies slide.
    """
    length = units(rig.scene)[1]
    load = load_unit(rig.scene)
    limit = rig.scene.friction.coefficient * rig.normal_load
    force_range = limits(limit, -limit)
    force_marks: list[Mark] = [
        Block((begin, end), force_range, _MOTIONS[motion][0])
        for motion, begin, end in rig.stretches()
    ]
    force_marks += [
        Curve(rig.time, limit, "cone", "f P"),
        Curve(rig.time, -limit, "cone", "−f P"),
        Curve(rig.time, rig.tangential_load, "c5 bold", "Q"),
    ]
    moved_curves = [
        Curve(rig.time, rig.actuator, "c1 dash", "U of the actuator"),
        Curve(rig.time, rig.contact, "c0", "U of the contact"),
        Curve(rig.time, rig.way, "c2 bold", "way that the bodies slide"),
    ]
    time = Axis(float(rig.time[0]), float(rig.time[-1]), "time")

    def panel(name: str, up: Axis, marks: Sequence[Mark], alt: str) -> Panel:
        return Panel(name, time, up, marks, alt, _WIDTH, 300.0, css="broad", time="x")

    panels = [
        panel("rig-force", Axis(*force_range, f"Q  [{load}]"), force_marks, "Q over time"),
        panel(
            "rig-way",
            Axis(*limits(*(curve.y for curve in moved_curves)), f"displacement  [{length}]"),
            [Rule(0.0, "zero"), *moved_curves],
            "Displacements over time",
        ),
    ]
    keys = [Key("c5 bold", "Q"), Key("cone", "±f P")]
    keys += [Key(curve.css, curve.label) for curve in moved_curves]
    motions_shown = {motion for motion, _, _ in rig.stretches()}
    keys += [Key(*_MOTIONS[motion], patch=True) for motion in Motion if motion in motions_shown]
    columns: Table = {
        "time": rig.time,
        f"Q [{load}]": rig.tangential_load,
        f"f P [{load}]": limit,
        f"way that the bodies slide [{length}]": rig.way,
        "motion in the step before": [_MOTIONS[Motion(k)][1] for k in rig.motions.tolist()],
    }
    return worded("rig_over_time", panels, columns, keys, columns=1, noun=rig.noun)


# ------------------------------------------------------------------------------------------ numbers
def rows_of(rig: RigMotion) -> list[tuple[str, str]]:
    """The first table: strokes, loads, dissipation, motions."""
    length = units(rig.scene)[1]
    load = load_unit(rig.scene)
    work = rig.solution.dissipation
    least_load = float(np.min(rig.normal_load))
    largest_load = float(np.max(rig.normal_load))
    loads = f"{least_load:.6g} to {largest_load:.6g}"
    rows = [
        (f"stroke of the actuator [{length}]", f"{np.ptp(rig.actuator):.6g}"),
        (f"stroke of the contact [{length}]", f"{np.ptp(rig.contact):.6g}"),
        (f"P [{load}]", f"{largest_load:.6g}" if least_load == largest_load else loads),
        (
            f"Q [{load}]",
            minus(f"{np.min(rig.tangential_load):.6g} to {np.max(rig.tangential_load):.6g}"),
        ),
        *([row_of_sliding(rig.solution)] if rig.scene.friction.coefficient else []),
        (f"dissipation W of the {rig.noun} [{energy_unit(rig.scene)}]", f"{work:.6g}"),
    ]
    for motion in Motion:
        share = rig.share(motion)
        if not share:
            continue
        words = f"{100 * share:.3g} % of the time"
        if motion in (Motion.FORWARD, Motion.BACK):
            words += f", over {rig.distance(motion):.6g} {length}"
        rows.append((_MOTIONS[motion][1], words))
    if rig.elements is not None:
        rows += _rows_of_elements(rig, rig.elements)
    return rows


def _rows_of_elements(rig: RigMotion, elements: RigMotion) -> list[tuple[str, str]]:
    """The same of finite elements, with the difference over theory's."""
    load = load_unit(rig.scene)
    length = units(rig.scene)[1]
    work = elements.solution.dissipation
    uncertainty = getattr(elements.solution, "dissipation_uncertainty", math.nan)
    words = f"{work:.6g}"
    if math.isfinite(uncertainty):
        words += f" ± {uncertainty:.1g}"
    if rig.solution.dissipation:
        words += f" ({100 * (work / rig.solution.dissipation - 1):+.3g} %)"
    force = elements.tangential_load
    rows = [
        (f"W by finite elements [{energy_unit(rig.scene)}]", minus(words)),
        (
            f"Q by finite elements [{load}]",
            minus(f"{np.min(force):.6g} to {np.max(force):.6g}"),
        ),
    ]
    # Of few increments one begins to slide within another: the middle slips only where all do.
    way = float(np.sum(np.abs(np.diff(elements.way))))
    if way > _NO_SLIDE * float(np.ptp(elements.actuator)):
        rows.append((f"slide by finite elements [{length}]", f"{way:.6g}"))
    return rows


def may_slide(rig: RigMotion) -> bool:
    """Whether bodies that do not slide as a whole may do so by the uncertainty of the inputs."""
    if rig.inputs is None or rig.inputs.sliding is None:
        return False
    return rig.inputs.sliding.is_in_reach


def _sentence(rig: RigMotion) -> str:
    """What matters first."""
    length = units(rig.scene)[1]
    way = rig.distance(Motion.FORWARD) + rig.distance(Motion.BACK)
    if way:
        sentence_on_slides = f"The bodies slide as a whole by {way:.6g} {length} in the {rig.noun}."
    elif may_slide(rig):
        sentence_on_slides = (
            f"Nothing slides as a whole in the {rig.noun}, but with these inputs the bodies may."
        )
    else:
        sentence_on_slides = f"Nothing slides as a whole in the {rig.noun}."
    return f"{sentence_on_slides} W = {rig.solution.dissipation:.6g} {energy_unit(rig.scene)}."


def _notes_of(rig: RigMotion) -> Iterator[str]:
    """Of both engines."""
    yield from rig.solution.record.notes
    if rig.beside is not None:
        for note in rig.beside.record.notes:
            yield f"finite elements: {note}"


def write(rig: RigMotion, out: str | Path, command: str, remarks: Sequence[str]) -> Path:
    """The page and the CSV of each figure, beside the solution that is saved there; returns the
    path of the page.

    `remarks` are sentences on which engine takes the scene.
    """
    program, digest = script()
    drawings = (_loop(rig), _over_time(rig))
    summary = summary_rows(rig.solution)
    with filled(out, fresh=("report.html", "figures/")) as folder:
        write_tables(drawings, folder)
        page = template("rig.html").render(
            title=rig.scene.title or rig.scene.name,
            scene=rig.scene,
            sentence=_sentence(rig),
            is_open=may_slide(rig),
            rows=rows_of(rig),
            summary=[row for row in summary if row[0] != "note"],
            notes=(*_notes_of(rig), *remarks),
            drawings=drawings,
            inputs=rig.inputs,
            input_words=input_words,
            command=command,
            script=program,
            script_hash=digest,
        )
        (folder / "report.html").write_text(page, encoding="utf-8")
    return Path(out) / "report.html"
