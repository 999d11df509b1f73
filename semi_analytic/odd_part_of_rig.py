"""What tilt and bulk strain of the bodies add to the dissipation of a rig's steady cycle.

The memory of `odd_memory` follows paths of few segments with smooth ends of strokes, and the loads
that follow from displacements are known step by step. So the steady cycle is stated again:

- where P rests, by its turning points: between them only the order counts;
- on an ellipse or harmonics, by harmonics of Q, for P is one of them;
- on other cycles, by straight steps between fewer rows. Their strokes end at vertices of the path.

The initial loading does not count in a steady cycle. Where one side of the contact slips alone,
that order does not hold: grids follow the same loads, see `answer_of_rig`.
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
from semi_analytic.driven import Driven
from semi_analytic.odd_memory import Declined, OddAnswer, odd_answer

# Instants of a cycle at which Q is taken for its harmonics, and these: twice as many change the
# work that they add by less than 1e-3 of itself.
_INSTANTS = 256
_HARMONICS = 24
# Steps of a cycle of neither kind.
_STEPS = 200
# Share of a load within which two are one.
_SAME = 1e-9
# Amplitudes below this share of the largest are none.
_NO_WAVE = 1e-7


def odd_part_of_rig(
    scene: Scene, effects: BodyEffects, driven: Driven, last_cycle: slice
) -> OddAnswer:
    """Friction work that tilt and bulk strain of finite bodies add in the steady cycle of a rig, in
    the second order of these small numbers.

    The cycle is the rows `last_cycle` of a path with displacements prescribed; `effects` are the
    numbers of the bodies, `driven` the loads that were found.

    Raises
    ------
    Declined
        Where the second order does not hold for the loads; where the bodies slide as a whole, or
        part.
    """
    if np.any(driven.followed.normal_load[last_cycle] <= 0):
        raise Declined("the bodies part")
    if np.any(driven.slide[last_cycle][1:] != 0):
        raise Declined("the bodies slide as a whole")
    return odd_answer(loads_of_cycle(scene, driven, last_cycle), effects)


def loads_of_cycle(
    scene: Scene, driven: Driven, last_cycle: slice, most_steps: int = _STEPS
) -> Scene:
    """The scene of a rig with the loads P and Q that were found in its last cycle, in the place of
    the displacements.

    Loads at constant P are a polygon of the turning points of Q, those of harmonic displacements
    sums of harmonics, others straight steps.

    Parameters
    ----------
    most_steps
        of a cycle that has neither constant P nor harmonics, at most

    Raises
    ------
    Declined
        Where Q rests.
    """
    load = driven.followed.normal_load[last_cycle]
    force = driven.followed.tangential_load[last_cycle]
    time = driven.time[last_cycle]
    load_of_cycle: HarmonicLoad | PolygonLoad
    if np.ptp(load) <= _SAME * float(np.max(load)):
        load_of_cycle = _turning_points(load, force)
    elif isinstance(scene.load, EllipseLoad | HarmonicLoad):
        load_of_cycle = _harmonics(time, load, force)
    else:
        load_of_cycle = _steps(load, force, most_steps)
    return scene.vary(load=load_of_cycle, rig=Rig(), cycles=2)


def _turning_points(load: Array, force: Array) -> PolygonLoad:
    """The cycle as straight steps between the turning points of Q, from the largest Q on."""
    rise = np.diff(force)
    moves = np.flatnonzero(rise)
    ends = moves[np.sign(rise[moves]) != np.sign(rise[np.roll(moves, -1)])] + 1
    if len(ends) < 2:
        raise Declined("Q rests")
    turns = force[ends]
    turns = np.roll(turns, -int(np.argmax(turns)))
    points = [(float(load[0]), float(turn)) for turn in turns]
    return PolygonLoad(initial_loading=(points[0],), cycle=tuple(points[1:]))


def _harmonics(time: Array, normal_load: Array, tangential_load: Array) -> HarmonicLoad:
    """One period of P and Q over time, (n,) each, as a harmonic load: means, amplitudes and phases
    of the first harmonics by Fourier's transform.

    Waves too small to matter have amplitude 0.
    """
    instants = time[0] + (time[-1] - time[0]) * np.arange(_INSTANTS) / _INSTANTS

    def waves(values: Array) -> tuple[float, tuple[tuple[float, float], ...]]:
        """Mean, amplitudes and phases in degrees."""
        fourier_terms = np.fft.rfft(np.interp(instants, time, values)) / _INSTANTS
        amplitudes = 2 * np.abs(fourier_terms[1 : _HARMONICS + 1])
        phases = -np.degrees(np.angle(fourier_terms[1 : _HARMONICS + 1]))
        amplitudes[amplitudes < _NO_WAVE * np.max(amplitudes)] = 0.0
        return float(fourier_terms[0].real), tuple(
            zip(amplitudes.tolist(), phases.tolist(), strict=True)
        )

    mean_normal_load, normal_waves = waves(normal_load)
    mean_tangential_load, tangential_waves = waves(tangential_load)
    return HarmonicLoad(
        mean_normal_load=mean_normal_load,
        normal_harmonics=normal_waves,
        mean_tangential_load=mean_tangential_load,
        tangential_harmonics=tangential_waves,
    )


def _steps(load: Array, force: Array, steps: int) -> PolygonLoad:
    """The cycle by straight steps between some of its rows."""
    rows = np.unique(np.linspace(0, len(load) - 1, steps + 1).astype(int))
    points = list(zip(load[rows].tolist(), force[rows].tolist(), strict=True))
    return PolygonLoad(initial_loading=(points[0],), cycle=tuple(points[1:-1]))
