"""The steady cycle of loads in phase, as `Findings`: by quadratures over its two strokes, without
memory curves and without grids. P, Q, bulk strain and tilt go there and back on one line.
"""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK
from scenes.array_types import Array
from semi_analytic.answer import (
    Findings,
    Question,
    is_between_edges,
    largest_error,
    mirrored_points,
    neglected_coupling,
)
from semi_analytic.bulk_and_tilt import PathLoads, path_loads_and_contact
from semi_analytic.loops_in_phase import STROKE_NODE_COUNT, Stroke, work_by_loads
from semi_analytic.memory import PROMISED_ERROR
from semi_analytic.tilted_profile import TiltedProfile

_INSTANTS_PER_CYCLE = 400  # of the cycle, besides turning points


@dataclass(frozen=True, eq=False)
class _CycleInstants:
    """Instants of one steady cycle of loads in phase, with loads and zones at each, (n,) each.

    Attributes
    ----------
    time
        times of the first cycle of the load path
    normal_load, tangential_load, tilt
        P and Q [force per thickness], tilt of the profile [rad]
    is_forward
        whether Q rises: slip is forward then, else in reverse
    contact_middle, contact_half_width, stick_middle, stick_half_width
        of the contact and of the stick zone [length]
    """

    time: Array
    normal_load: Array
    tangential_load: Array
    tilt: Array
    is_forward: NDArray[np.bool_]
    contact_middle: Array
    contact_half_width: Array
    stick_middle: Array
    stick_half_width: Array

    @property
    def contact_edges(self) -> Array:
        """Left and right edge of the contact at each instant, (n, 2) [length]."""
        return np.stack(
            [
                self.contact_middle - self.contact_half_width,
                self.contact_middle + self.contact_half_width,
            ],
            axis=-1,
        )

    @property
    def stick_edges(self) -> Array:
        """Left and right edge of the stick zone at each instant, (n, 2) [length]."""
        return np.stack(
            [self.stick_middle - self.stick_half_width, self.stick_middle + self.stick_half_width],
            axis=-1,
        )

    @property
    def permanent_stick_edges(self) -> Array:
        """Left and right edge of the zone that sticks throughout, (2,) [length]: the smallest stick
        zone of the cycle, at the largest Q.
        """
        return np.asarray(self.stick_edges[np.argmax(self.tangential_load)])


def findings_in_phase(question: Question, strokes: tuple[Stroke, Stroke]) -> Findings:
    """Half-plane answer for the steady cycle of loads in phase: loads, pressure, edges, state of
    contact and friction work. P, Q, bulk strain and tilt go there and back on one line.

    Instants are those of the second cycle, which is steady. What depends on the initial loading is
    NaN: shear, slip and the tangential displacement. `strokes` are the forward and the reverse half
    of the cycle, in which Q rises and falls, with slip in one direction each. The question holds
    scene, points and the fields that are wanted.
    """
    clock_at_start = clock.perf_counter()
    scene = question.scene
    # P, Q, bulk strain and tilt over time, and the contact under any tilt
    path_loads, tilted_contact = path_loads_and_contact(scene)
    instants = _instants_with_zones(path_loads, tilted_contact, strokes)
    x = question.x
    if x is None:
        x = mirrored_points(1.05 * float(np.max(np.abs(instants.contact_edges))))
    fields = _fields_over_cycle(question, instants, tilted_contact, x)
    # friction work and its density, with the relative error of each
    works, errors = _works_and_errors(question, strokes, x)
    return Findings(
        time=instants.time + _period_of(path_loads),  # the second cycle has the loads of the first
        x=x,
        values=_loads_and_edges(instants, path_loads, tilted_contact) | fields | works,
        termination="steady",
        message="the second cycle ends in the state it started from",
        notes=tuple(neglected_coupling(scene.material)),
        # PROMISED_ERROR: 1e-12; STROKE_NODE_COUNT: 48
        errors={name: error for name, error in errors.items() if error > PROMISED_ERROR},
        counts={"quadrature_nodes": 4 * STROKE_NODE_COUNT**2, "cycles_solved": 1},
        seconds={"dissipation": clock.perf_counter() - clock_at_start},
    )


def _period_of(path_loads: PathLoads) -> float:
    """Duration of one cycle of the load path [time]."""
    path = path_loads.path
    return path.cycle[-1].end - path.cycle_start


def _instants_with_zones(
    path_loads: PathLoads, tilted_contact: TiltedProfile, strokes: tuple[Stroke, Stroke]
) -> _CycleInstants:
    """Instants of the first cycle of the load path, with loads, contact and stick zone at each.

    `path_loads` gives P, Q, bulk strain and tilt over time, `tilted_contact` the contact under P
    and a tilt. `strokes` are the forward and the reverse half of the steady cycle, which give the
    stick zone.
    """
    time, (normal_load, tangential_load, _, tilt) = _instants_of_cycle(path_loads)
    is_forward = _is_rising(time, tangential_load, _period_of(path_loads))
    contact_middle, contact_half_width = tilted_contact.centre_and_half_width_under(
        normal_load, tilt
    )
    stick_middle, stick_half_width = _stick_zones(strokes, tangential_load, is_forward)
    return _CycleInstants(
        time=time,
        normal_load=normal_load,
        tangential_load=tangential_load,
        tilt=tilt,
        is_forward=is_forward,
        contact_middle=contact_middle,
        contact_half_width=contact_half_width,
        stick_middle=stick_middle,
        stick_half_width=stick_half_width,
    )


def _loads_and_edges(
    instants: _CycleInstants, path_loads: PathLoads, tilted_contact: TiltedProfile
) -> dict[str, Any]:
    """Loads, bulk stress, tilt, moment, and the zones of contact and of stick at the instants of a
    steady cycle, by their names in a solution.

    Values over time are (n,), edges (n, 2); the permanent stick zone has numbers of its own.
    `path_loads` has the bulk stresses over time. `tilted_contact` gives the moment of the pressure
    [force].
    """
    stress_of_lower_body, stress_of_upper_body = path_loads.bulk_stresses(instants.time)
    permanent_stick_edges = instants.permanent_stick_edges
    return {
        "normal_load": instants.normal_load,
        "tangential_load": instants.tangential_load,
        "contact_edges": instants.contact_edges,
        "stick_edges": instants.stick_edges,
        "contact_half_width": instants.contact_half_width,
        "stick_half_width": instants.stick_half_width,
        "permanent_stick_half_width": float(np.diff(permanent_stick_edges)[0]) / 2,
        "permanent_stick_edges": permanent_stick_edges,
        "steady_from": 1,
        "bulk_stress_lower": stress_of_lower_body,
        "bulk_stress_upper": stress_of_upper_body,
        "tilt": instants.tilt,
        "moment": tilted_contact.moment(
            instants.contact_middle,
            instants.contact_half_width,
            instants.normal_load,
            instants.tilt,
        ),
    }


def _fields_over_cycle(
    question: Question, instants: _CycleInstants, tilted_contact: TiltedProfile, x: Array
) -> dict[str, NDArray[Any]]:
    """Fields over the steady cycle by their names in a solution: pressure and state at n instants
    and points x (k,), (n, k) each, and the normal approach (n,) [length].

    A field that the question does not want is NaN, a state that it does not want is open. Shear,
    slip and the tangential displacement depend on the initial loading: they are NaN always.
    """
    nan_at_points = np.broadcast_to(np.nan, (len(instants.time), len(x)))
    nan_at_instants = nan_at_points[:, 0]
    fields: dict[str, NDArray[Any]] = {
        "pressure": nan_at_points,
        "shear": nan_at_points,
        "slip": nan_at_points,
        "state": np.full(nan_at_points.shape, np.int8(OPEN)),
        "tangential_displacement": nan_at_instants,
        "normal_approach": nan_at_instants,
    }
    contact_middle = instants.contact_middle
    contact_half_width = instants.contact_half_width
    if question.wants("pressure"):
        fields["pressure"] = tilted_contact.pressure_over(x, contact_middle, contact_half_width)
    if question.wants("state"):
        fields["state"] = _states_at_points(instants, x)
    if question.wants("normal_approach"):
        fields["normal_approach"] = tilted_contact.approach(
            contact_middle, contact_half_width, instants.normal_load, instants.tilt
        )
    return fields


def _states_at_points(instants: _CycleInstants, x: Array) -> NDArray[np.int8]:
    """State of each point x (k,) at each instant of a steady cycle, (n, k).

    It is open outside the contact and stick inside the stick zone. Elsewhere it is forward slip
    while Q rises, reverse slip while Q falls.
    """
    slip_state = np.where(instants.is_forward, np.int8(SLIP_FORWARD), np.int8(SLIP_REVERSE))
    states_in_contact = np.where(
        is_between_edges(instants.stick_edges, x), np.int8(STICK), slip_state[:, None]
    )
    return np.where(is_between_edges(instants.contact_edges, x), states_in_contact, np.int8(OPEN))


def _works_and_errors(
    question: Question, strokes: tuple[Stroke, Stroke], x: Array
) -> tuple[dict[str, Any], dict[str, float]]:
    """Friction work of the steady cycle [energy per thickness] and its density at points x (k,)
    [energy per area], by their names in a solution. Second: the relative errors of those that are
    wanted.

    `strokes` are the forward and the reverse half of the cycle. What the question does not want is
    NaN and has no error.
    """
    friction_work = math.nan
    loop_work = math.nan
    density = np.full(len(x), math.nan)
    errors = {}
    if question.wants("dissipation"):
        friction_work, errors["dissipation"] = _work_and_error(strokes)
    if question.wants("loop_work"):
        # the closed integral of the loads over their displacements, equal to the friction work
        loop_work = work_by_loads(strokes)
    if question.wants("dissipation_density"):
        density, errors["dissipation_density"] = _density_and_error(strokes, x)
    works = {
        "dissipation": friction_work,
        "loop_work": loop_work,
        "cycle_dissipation": np.array([friction_work]),
        "dissipation_density": density,
    }
    return works, errors


def _instants_of_cycle(path_loads: PathLoads) -> tuple[Array, Array]:
    """Times of the first cycle (n,), and P, Q, bulk strain and tilt at them (4, n). They are evenly
    spread over each load segment, with every turning point. `path_loads` holds the load path, whose
    cycle is a sequence of segments.
    """
    segments = path_loads.path.cycle
    times_of_segments = []
    for segment in segments:
        # 400 in all
        n_times = _INSTANTS_PER_CYCLE // len(segments) + 2
        even_times = np.linspace(segment.start, segment.end, n_times)[1:]
        times_of_segments.append(
            np.unique(np.append(even_times, path_loads.turning_times(segment)))
        )
    time = np.concatenate(times_of_segments)
    return time, path_loads.loads_at(time)


def _is_rising(time: Array, tangential_load: Array, period: float) -> NDArray[np.bool_]:
    """Whether Q rises at each instant (n,) of a cycle, from its least value to its largest."""
    time_of_least = time[np.argmin(tangential_load)]
    time_of_largest = time[np.argmax(tangential_load)]
    rise_duration = (time_of_largest - time_of_least) % period
    return np.asarray((time - time_of_least) % period <= rise_duration)


def _stick_zones(
    strokes: tuple[Stroke, Stroke], tangential_load: Array, is_forward: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Middles and half-widths of the stick zone at instants of the steady cycle, (n,) each
    [length].

    `tangential_load` (n,) is Q there, `is_forward` (n,) whether the stroke is the one in which Q
    rises. `strokes` are the forward and the reverse half of the cycle; index 1 of their loads, at
    the begin and as changes, is Q.
    """
    forward_stroke, reverse_stroke = strokes
    share_of_stroke = np.clip(
        (tangential_load - forward_stroke.loads_at_begin[1]) / forward_stroke.load_changes[1], 0, 1
    )
    stick_middle, stick_half_width = np.where(
        is_forward,
        forward_stroke.stick_zone(share_of_stroke),
        reverse_stroke.stick_zone(1 - share_of_stroke),
    )
    return stick_middle, stick_half_width


def _work_and_error(strokes: tuple[Stroke, Stroke]) -> tuple[float, float]:
    """Friction work W of the steady cycle [energy per thickness], and its relative error: what half
    as many quadrature nodes change.
    """
    friction_work = math.fsum(stroke.work(STROKE_NODE_COUNT) for stroke in strokes)
    work_by_half_the_nodes = math.fsum(stroke.work(STROKE_NODE_COUNT // 2) for stroke in strokes)
    return friction_work, abs(work_by_half_the_nodes / friction_work - 1)


def _density_and_error(strokes: tuple[Stroke, Stroke], x: Array) -> tuple[Array, float]:
    """Friction work per area W(x) of the steady cycle at points (k,), and its error over the
    largest: what half of the 48 quadrature nodes change. `strokes` are the forward and the
    reverse half of the cycle.
    """
    forward_stroke, reverse_stroke = strokes
    density = forward_stroke.work_density(x, STROKE_NODE_COUNT) + reverse_stroke.work_density(
        x, STROKE_NODE_COUNT
    )
    density_by_half_the_nodes = forward_stroke.work_density(
        x, STROKE_NODE_COUNT // 2
    ) + reverse_stroke.work_density(x, STROKE_NODE_COUNT // 2)
    largest_density = float(np.max(density))
    largest_change = largest_error(np.abs(density_by_half_the_nodes - density))
    return density, largest_change / largest_density if largest_density > 0 else 0.0
