"""What an answer says of a rig: the loads that were found, in a scene of their own, and when the
bodies slide as a whole and how far.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.run import PathRun
from halfplane_fe.scales import Scales
from scenes import STICK, PolygonLoad, Rig, Scene

# Slides that a note names one by one, in the last cycle and before it.
_MOST_SLIDES_NAMED = 4
_MOST_EARLIER_SLIDES_NAMED = 2


def scene_of_loads(scene: Scene, run: PathRun, load_unit: float) -> Scene:
    """The scene of a rig under load control in the place of displacement control: P and Q that the
    finite elements found at the end of each increment, joined by straight lines from P = Q = 0.

    The last load cycle of the run becomes the cycle, which its first point closes. What is before
    it is the initial loading. Where the last cycle was not completed, all of the path is.

    Parameters
    ----------
    scene
        with a rig, whose actuators prescribe movements
    run
        contact states along the path, with scaled P and Q; index of the state at the start of each
        cycle, and whether the last one was not completed
    load_unit
        what P and Q of the run are scaled by [force per thickness]
    """
    states = run.states
    # (P, Q) at the end of each increment
    load_points = [
        (load_unit * state.normal_load, load_unit * state.tangential_load) for state in states
    ]
    initial_loading = tuple(load_points[1:])
    cycle: tuple[tuple[float, float], ...] = ()
    if run.cycle_starts and not run.last_revolution_failed:
        first_of_cycle = run.cycle_starts[-1]
        initial_loading = tuple(load_points[1 : first_of_cycle + 1])
        cycle = tuple(load_points[first_of_cycle + 1 : -1])
    times = tuple(state.time for state in states)
    polygon = PolygonLoad(initial_loading=initial_loading, cycle=cycle, times=times)
    return scene.vary(load=polygon, rig=Rig(), cycles=1)


class _Slide(NamedTuple):
    """One spell of gross sliding, scaled.

    Attributes
    ----------
    begin, end
        times
    distance
        slid by the upper body over the lower one, along +x
    work
        of friction, positive
    """

    begin: float
    end: float
    distance: float
    work: float


def _slides_of(friction: float, states: list[InterfaceState]) -> list[_Slide]:
    """Spells of gross sliding along a sequence of contact states: increments at whose end every
    touching node slips, those that follow on each other in one direction joined.

    The bodies slide as a whole by the slip of the node that slips least; the friction work of an
    increment is `friction` times its mean normal load times that distance. Each spell has its first
    and last instant, its distance (with sign) and its work. All is scaled.
    """
    slides: list[_Slide] = []
    for state_before, state_after in pairwise(states):
        touches_throughout = state_before.is_closed & state_after.is_closed  # (n,) nodes
        if np.any(state_after.node_states == STICK) or not np.any(touches_throughout):
            continue

        slip = (state_after.slip - state_before.slip)[touches_throughout]
        distance = float(slip[np.argmin(np.abs(slip))])
        mean_normal_load = (state_before.normal_load + state_after.normal_load) / 2
        work = friction * mean_normal_load * abs(distance)

        # Joined with the spell before if that ended here and had the same direction.
        if slides and slides[-1].end == state_before.time and slides[-1].distance * distance > 0:
            slide_before = slides[-1]
            slides[-1] = _Slide(
                slide_before.begin,
                state_after.time,
                slide_before.distance + distance,
                slide_before.work + work,
            )
        else:
            slides.append(_Slide(state_before.time, state_after.time, distance, work))
    return slides


def notes_of_rig(
    scene: Scene, problem: ContactProblem, run: PathRun, scales: Scales
) -> tuple[str, ...]:
    """Sentences for the reader of a solution in which actuators move the bodies: which loads were
    unknown, how exactly the movements are met, and where the bodies slide as a whole.

    A tangential actuator moves by U_act, of which Q/k_s is the stretch of its spring, of stiffness
    k_s. A scene that states the approach of a normal actuator leaves P unknown too. Displacements
    of half-planes are relative to the surface at the datum length from the contact.

    Parameters
    ----------
    scene
        with the rig, and `unit_words`: names of the units of force, length and stress
    problem, run
        the contact problem and its states along the path, scaled
    scales
        load, half-width and modulus that they are scaled by
    """
    _, length_unit, _ = scene.unit_words
    displacement_unit = scales.load / scales.modulus
    loads_text = "P and Q are unknowns" if scene.load.states_approach else "Q is an unknown"
    largest_position_error = _largest_position_error(problem, run.states) * displacement_unit
    displacement_text = "U here is that of the contact, U_act - Q/k_s"
    if scene.bodies.half_planes:
        datum_text = f"{scene.profile.datum_length:.6g} {length_unit}"
        displacement_text = f"U and approach here count from {datum_text}, as in every answer"
    note = (
        f"rig: {loads_text} of each increment, at whose end the actuators are where the rig"
        f" prescribes to {largest_position_error:.1g} {length_unit}; {displacement_text}"
    )
    return (note, *_notes_of_slides(scene, problem.friction, run, scales))


def _notes_of_slides(scene: Scene, friction: float, run: PathRun, scales: Scales) -> Iterator[str]:
    """Sentences on gross sliding: when the bodies slide as a whole, how far, and the friction work
    of it, in the last cycle and before; on the whole path where it does not repeat.

    Parameters
    ----------
    scene
        `unit_words` are names of the units of force, length and stress
    friction
        coefficient f
    run
        scaled states along the path, and index of the state at the start of each cycle
    scales
        load P and modulus E* that turn them into the scene's units
    """
    force_unit, length_unit, _ = scene.unit_words
    displacement_unit = scales.load / scales.modulus
    first_step = run.cycle_starts[-1] if run.cycle_starts else 0
    span_text = "the last cycle" if run.cycle_starts else "the path"

    # In the last cycle: up to four spells one by one.
    slides = _slides_of(friction, run.states[first_step:])
    if not slides:
        yield f"gross sliding: none in {span_text}"
    else:
        total_distance = sum(abs(slide.distance) for slide in slides) * displacement_unit
        friction_work = sum(slide.work for slide in slides) * scales.load * displacement_unit
        slides_in_words = "; ".join(
            _slide_in_words(slide, displacement_unit, length_unit)
            for slide in slides[:_MOST_SLIDES_NAMED]
        )
        rest_text = (
            f"; and {len(slides) - _MOST_SLIDES_NAMED} more"
            if len(slides) > _MOST_SLIDES_NAMED
            else ""
        )
        yield (
            f"gross sliding: in {span_text} the bodies slide as a whole by {total_distance:.6g}"
            f" {length_unit}, which takes {friction_work:.6g}"
            f" {force_unit}·{length_unit}/{length_unit} of the dissipation: {slides_in_words}"
            f"{rest_text}"
        )

    # Before it: up to two spells.
    slides_before = _slides_of(friction, run.states[: first_step + 1])
    if slides_before:
        earlier_slides_in_words = "; ".join(
            _slide_in_words(slide, displacement_unit, length_unit)
            for slide in slides_before[:_MOST_EARLIER_SLIDES_NAMED]
        )
        yield f"gross sliding: before it {earlier_slides_in_words}"


def _slide_in_words(slide: _Slide, displacement_unit: float, length_unit: str) -> str:
    """When, in which direction and how far the bodies slide, as part of a sentence. The distance of
    a slide is scaled: times `displacement_unit` it is in the scene's units.
    """
    direction = "forward" if slide.distance > 0 else "back"
    return (
        f"from time {slide.begin:.6g} to {slide.end:.6g} {direction} by"
        f" {abs(slide.distance) * displacement_unit:.6g} {length_unit}"
    )


def _largest_position_error(problem: ContactProblem, states: list[InterfaceState]) -> float:
    """Largest distance, over all states, between where an actuator is and where the rig prescribes
    it to be; scaled.

    An actuator moves by the rigid motion of the bodies (approach, or tangential displacement
    `shift`) plus its compliance times the load. `problem.actuators` are the compliances of the
    normal and the tangential one, None where the load is given instead.
    """
    largest_error = 0.0
    for state in states[1:]:
        rigid_motions = (state.approach, state.shift)
        loads = (state.normal_load, state.tangential_load)
        for direction, compliance in enumerate(problem.actuators):  # normal, tangential
            if compliance is not None:
                movement = rigid_motions[direction] + compliance * loads[direction]
                # `loads` of a state has the movement in the place of the load here.
                prescribed_movement = state.loads[direction]
                largest_error = max(largest_error, abs(movement - prescribed_movement))
    return largest_error
