"""Friction work that tilt and bulk strain of the bodies add in the steady cycle of a rig, where
displacements are prescribed.

`odd_memory` takes load paths of few segments, with smooth ends of strokes. The loads that follow
from displacements are known at many instants. So the steady cycle is replaced:

- at constant P, by a polygon of the turning points of Q: between them only their order counts;
- on an ellipse or harmonics, by a sum of harmonics of P and of Q;
- on other cycles, by straight steps between fewer instants. Their strokes end at vertices.

The initial loading does not count in a steady cycle. Where one side of the contact slips alone, the
second order does not hold: grids follow the same loads, see `answer_of_rig`.
"""

from __future__ import annotations

import numpy as np

from scenes import (
    BodyEffects,
    EllipseLoad,
    HarmonicLoad,
    PolygonLoad,
    Rig,
    Scene,
)
from scenes.array_types import Array
from semi_analytic.driven import DrivenPath
from semi_analytic.odd_memory import DeclinedError, SecondOrderAnswer, second_order_answer

# Instants of a cycle from which harmonics are computed, and harmonics: twice as many change the
# added work by less than 1e-3 of itself.
_INSTANTS_OF_TRANSFORM = 256
_HARMONIC_COUNT = 24
# Steps of a cycle with neither constant P nor harmonics.
_MOST_STEPS = 200
# Two loads are equal within this fraction of the larger.
_EQUALITY_TOLERANCE = 1e-9
# Amplitudes below this fraction of the largest of the same load are set to 0.
_LEAST_AMPLITUDE_SHARE = 1e-7


def second_order_answer_of_rig(
    scene: Scene, effects: BodyEffects, driven_path: DrivenPath, last_cycle: slice
) -> SecondOrderAnswer:
    """Friction work that tilt and bulk strain of finite bodies add in the steady cycle of a rig, to
    the second order in both. With it come the centres of contact and stick.

    Tilt and strain make tractions that are odd in x. The displacements that the rig prescribes are
    replaced by the loads P and Q that followed from them. The cycle is repeated: the last of the
    returned `works` is that of the steady cycle.

    Parameters
    ----------
    scene
        scene with the rig; its profile must be a parabola
    effects
        tilt and strain per load
    driven_path
        `followed_path.normal_load` (n,) is P and `slide_distance` (n,) is the gross sliding of the
        step that ends at each instant, along the prescribed displacements
    last_cycle
        rows (instants) of the steady cycle

    Raises
    ------
    DeclinedError
        - where the contact slides as a whole, or the bodies separate;
        - where the loads of the cycle are constant;
        - where one side of the contact slips alone, or the second order does not hold for another
          reason.
    """
    if np.any(driven_path.followed_path.normal_load[last_cycle] <= 0):
        raise DeclinedError("the bodies part")
    # The slide of a row is that of the step before it: the first row's is not of this cycle.
    if np.any(driven_path.slide_distance[last_cycle][1:] != 0):
        raise DeclinedError("the bodies slide as a whole")
    # A path of few segments or harmonics takes the place of the many instants.
    return second_order_answer(loads_of_cycle(scene, driven_path, last_cycle), effects)


def loads_of_cycle(
    scene: Scene, driven_path: DrivenPath, last_cycle: slice, most_steps: int = _MOST_STEPS
) -> Scene:
    """The scene of a rig with displacements replaced by the loads P and Q of its last cycle, as a
    load path without rig.

    At constant P the path is a polygon of the turning points of Q. For harmonic displacements it is
    a sum of harmonics, for others straight steps.

    Parameters
    ----------
    scene
        scene of the rig; `scene.load` holds the prescribed displacements
    driven_path, last_cycle
        the followed path with P and Q at each instant, and its rows (instants) in the last cycle
    most_steps
        largest number of straight steps

    Raises
    ------
    DeclinedError
        Where P and Q are constant.
    """
    normal_load = driven_path.followed_path.normal_load[last_cycle]
    tangential_load = driven_path.followed_path.tangential_load[last_cycle]
    time = driven_path.time[last_cycle]
    # Constant P is one that varies by no more than 1e-9 of itself.
    load_of_cycle: HarmonicLoad | PolygonLoad
    if np.ptp(normal_load) <= _EQUALITY_TOLERANCE * float(np.max(normal_load)):
        load_of_cycle = _polygon_of_turning_points(normal_load, tangential_load)
    elif isinstance(scene.load, EllipseLoad | HarmonicLoad):
        load_of_cycle = _sum_of_harmonics(time, normal_load, tangential_load)
    else:
        load_of_cycle = _straight_steps(normal_load, tangential_load, most_steps)
    return scene.vary(load=load_of_cycle, rig=Rig(), cycles=2)


def _polygon_of_turning_points(normal_load: Array, tangential_load: Array) -> PolygonLoad:
    """The cycle of n rows of P and Q at constant P, as a polygon of straight lines in the P-Q plane
    between the turning points of Q.

    It begins at the turning point with the largest Q. DeclinedError where Q does not turn round.
    """
    # Interval k is that from row k to row k + 1: those in which Q changes, and whether Q goes the
    # opposite direction during the next of them. The one after the last is the first.
    changes_of_tangential_load = np.diff(tangential_load)
    intervals_with_change = np.flatnonzero(changes_of_tangential_load)
    next_intervals_with_change = np.roll(intervals_with_change, -1)
    turns_back = np.sign(changes_of_tangential_load[intervals_with_change]) != np.sign(
        changes_of_tangential_load[next_intervals_with_change]
    )
    turning_rows = intervals_with_change[turns_back] + 1
    if len(turning_rows) < 2:
        raise DeclinedError("Q rests")
    turning_loads = tangential_load[turning_rows]
    turning_loads = np.roll(turning_loads, -int(np.argmax(turning_loads)))
    loads_at_vertices = [
        (float(normal_load[0]), float(turning_load)) for turning_load in turning_loads
    ]
    return PolygonLoad(initial_loading=(loads_at_vertices[0],), cycle=tuple(loads_at_vertices[1:]))


def _sum_of_harmonics(time: Array, normal_load: Array, tangential_load: Array) -> HarmonicLoad:
    """One period of P and Q over time, (n,) each, as a load of means and the first 24 harmonics, by
    the discrete Fourier transform.

    Amplitudes of one load below 1e-7 of the largest are set to 0.
    """
    # 256 instants; 24 harmonics are kept.
    equal_times = (
        time[0] + (time[-1] - time[0]) * np.arange(_INSTANTS_OF_TRANSFORM) / _INSTANTS_OF_TRANSFORM
    )

    def mean_and_harmonics(load: Array) -> tuple[float, tuple[tuple[float, float], ...]]:
        """Mean of P or Q at n times, and (amplitude, phase in degrees) of each harmonic."""
        fourier_terms = np.fft.rfft(np.interp(equal_times, time, load)) / _INSTANTS_OF_TRANSFORM
        amplitudes = 2 * np.abs(fourier_terms[1 : _HARMONIC_COUNT + 1])
        phases = -np.degrees(np.angle(fourier_terms[1 : _HARMONIC_COUNT + 1]))
        amplitudes[amplitudes < _LEAST_AMPLITUDE_SHARE * np.max(amplitudes)] = 0.0
        return float(fourier_terms[0].real), tuple(
            zip(amplitudes.tolist(), phases.tolist(), strict=True)
        )

    mean_normal_load, normal_harmonics = mean_and_harmonics(normal_load)
    mean_tangential_load, tangential_harmonics = mean_and_harmonics(tangential_load)
    return HarmonicLoad(
        mean_normal_load=mean_normal_load,
        normal_harmonics=normal_harmonics,
        mean_tangential_load=mean_tangential_load,
        tangential_harmonics=tangential_harmonics,
    )


def _straight_steps(normal_load: Array, tangential_load: Array, n_steps: int) -> PolygonLoad:
    """The cycle of P and Q at n instants, (n,) each, as at most `n_steps` straight steps between
    some of these instants, evenly chosen by their number.
    """
    rows = np.unique(np.linspace(0, len(normal_load) - 1, n_steps + 1).astype(int))
    loads_at_vertices = list(
        zip(normal_load[rows].tolist(), tangential_load[rows].tolist(), strict=True)
    )
    return PolygonLoad(
        initial_loading=(loads_at_vertices[0],), cycle=tuple(loads_at_vertices[1:-1])
    )
