"""Rigs: movements of actuators in the place of the loads P and Q, as loads of the contact problem.

Between an actuator and the contact is a compliance c, that of the rig's spring and of the bodies
beyond the datum of the condensed ones. A load that is a movement has its own row in the linear
systems (`systems`)::

    P, Q given              sum p = P,                 sum q = Q
    movements given         approach + c_n P = d,      U + c_t Q = u

so that P or Q is one more unknown of each increment. Where U is given, the bodies may slide on each
other as a whole: the contact still has an answer when no node sticks.

# notation: 1/E* = sum of (1 - nu^2)/E, L distance from the contact at which a half-plane counts as
#           unmoved
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from scenes import STICK, HalfPlane, LoadPath, PolygonLoad, Rig, Scene
from scenes.array_types import Array

if TYPE_CHECKING:
    from halfplane_fe.contact import ContactProblem, InterfaceState
    from halfplane_fe.run import PathRun
    from halfplane_fe.scales import Scales

# Slides that a note names one by one.
_MOST_NAMED = 4


class Actuators(NamedTuple):
    """Which of the first two loads are movements.

    Attributes
    ----------
    normal, tangential
        compliance between actuator and contact, scaled (E* over that of a load per thickness);
        None where P or Q is given
    """

    normal: float | None = None
    tangential: float | None = None

    @property
    def are_there(self) -> bool:
        """Whether any load is a movement."""
        return self.normal is not None or self.tangential is not None


LOADS_ARE_GIVEN = Actuators()


def path_of(scene: Scene) -> LoadPath:
    """The path of the loads, or of the movements in their place."""
    return scene.load.path_of_actuators() if scene.load.is_driven else scene.load.path()


def actuators_of(scene: Scene, datum: float) -> Actuators:
    """What a scene prescribes, at bodies whose half-planes are condensed with a datum length."""
    load = scene.load
    if not load.is_driven:
        return LOADS_ARE_GIVEN
    rig = scene.rig
    modulus = 1 / _compliance(scene, half_planes_alone=False)
    # Of real bodies a half-plane among them counts from where every answer does.
    prescribed_at = rig.datum_length or scene.profile.datum_length
    beyond = compliance_beyond(scene, prescribed_at / datum) * modulus
    normal = beyond + modulus / (rig.normal_stiffness or math.inf)
    tangential = beyond + modulus / (rig.tangential_stiffness or math.inf)
    return Actuators(normal if load.states_approach else None, tangential)


def compliance_beyond(scene: Scene, ratio: float) -> float:
    """What half-planes give way, per load, between their datum and `ratio` times that distance
    [1 / stress]: (2/pi) (1 - nu^2)/E ln(ratio) each. Other bodies stand on something.
    """
    return 2 / math.pi * _compliance(scene, half_planes_alone=True) * math.log(ratio)


def _compliance(scene: Scene, *, half_planes_alone: bool) -> float:
    """Sum of (1 - nu^2)/E of the bodies."""
    bodies = (
        (scene.bodies.lower, scene.material.lower),
        (scene.bodies.upper, scene.material.upper),
    )
    return sum(
        (1 - material.poisson_ratio**2) / material.young_modulus
        for shape, material in bodies
        if isinstance(shape, HalfPlane) or not half_planes_alone
    )


# ------------------------------------------------------------------------------------- the answer
def scene_of_loads(scene: Scene, run: PathRun, load_unit: float) -> Scene:
    """The scene with the P and Q that were found at the ends of increments, in the place of the
    movements; what is before the last revolution is initial loading.
    """
    states = run.states
    points = [
        (load_unit * state.normal_load, load_unit * state.tangential_load) for state in states
    ]
    loading = tuple(points[1:])
    cycle: tuple[tuple[float, float], ...] = ()
    if run.cycle_density and run.cycle_starts:
        begin = run.cycle_starts[-1]
        loading = tuple(points[1 : begin + 1])
        cycle = tuple(points[begin + 1 : -1])
    times = tuple(state.time for state in states)
    polygon = PolygonLoad(initial_loading=loading, cycle=cycle, times=times)
    return scene.vary(load=polygon, rig=Rig(), cycles=1)


class _Slide(NamedTuple):
    """One stretch of gross sliding: its times, its way, of the upper body over the lower one along
    +x, its friction work; scaled.
    """

    begin: float
    end: float
    way: float
    work: float


def _slides_of(friction: float, states: list[InterfaceState]) -> list[_Slide]:
    """The stretches in which every node slides that touches. The bodies slide by what the node
    slips that slips least.
    """
    slides: list[_Slide] = []
    for start, end in pairwise(states):
        touching = start.closed & end.closed
        if np.any(end.state == STICK) or not np.any(touching):
            continue
        slip = (end.slip - start.slip)[touching]
        way = float(slip[np.argmin(np.abs(slip))])
        mean_load = (start.normal_load + end.normal_load) / 2
        part = _Slide(start.time, end.time, way, friction * mean_load * abs(way))
        if slides and slides[-1].end == part.begin and slides[-1].way * way > 0:
            first = slides[-1]
            slides[-1] = _Slide(first.begin, part.end, first.way + way, first.work + part.work)
        else:
            slides.append(part)
    return slides


def notes_of_rig(
    scene: Scene, problem: ContactProblem, run: PathRun, scales: Scales
) -> tuple[str, ...]:
    """How P and Q were found, and when the bodies slide as a whole and how far."""
    _, length, _ = scene.unit_words
    movement = scales.load / scales.modulus
    loads = "P and Q are unknowns" if scene.load.states_approach else "Q is an unknown"
    miss = _largest_miss(problem, run.states) * movement
    found = (
        f"rig: {loads} of each increment, at whose end the actuators are where the rig prescribes"
        f" to {miss:.1g} {length}; U is that of the contact"
    )
    return (found, *_notes_of_slides(scene, problem.friction, run, scales))


def _notes_of_slides(scene: Scene, friction: float, run: PathRun, scales: Scales) -> Iterator[str]:
    """When the bodies slide as a whole and how far, in the last cycle and before it, or on the
    path.
    """
    force, length, _ = scene.unit_words
    movement = scales.load / scales.modulus
    first = run.cycle_starts[-1] if run.cycle_starts else 0
    what = "the last cycle" if run.cycle_starts else "the path"
    slides = _slides_of(friction, run.states[first:])
    if not slides:
        yield f"gross sliding: none in {what}"
    else:
        way = sum(abs(slide.way) for slide in slides) * movement
        work = sum(slide.work for slide in slides) * scales.load * movement
        named = "; ".join(_in_words(slide, movement, length) for slide in slides[:_MOST_NAMED])
        more = f"; and {len(slides) - _MOST_NAMED} more" if len(slides) > _MOST_NAMED else ""
        yield (
            f"gross sliding: in {what} the bodies slide as a whole by {way:.6g} {length}, which"
            f" takes {work:.6g} {force}·{length}/{length} of the dissipation: {named}{more}"
        )
    before = _slides_of(friction, run.states[: first + 1])
    if before:
        in_words = "; ".join(_in_words(slide, movement, length) for slide in before[:2])
        yield f"gross sliding: before it {in_words}"


def _in_words(slide: _Slide, movement: float, length: str) -> str:
    direction = "forward" if slide.way > 0 else "back"
    return (
        f"from time {slide.begin:.6g} to {slide.end:.6g} {direction} by"
        f" {abs(slide.way) * movement:.6g} {length}"
    )


def _largest_miss(problem: ContactProblem, states: list[InterfaceState]) -> float:
    """How far an actuator is from where it is to be at most, scaled."""
    largest = 0.0
    for state in states[1:]:
        rigid: tuple[Array, ...] = (state.values[0], state.values[1])
        loads = (state.normal_load, state.tangential_load)
        for number, compliance in enumerate(problem.actuators):
            if compliance is not None:
                moved = rigid[number] + compliance * loads[number]
                largest = max(largest, abs(float(moved - state.loads[number])))
    return largest
