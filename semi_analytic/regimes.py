"""Running-condition fretting map: partial slip, mixed regime and gross sliding over the stroke of
the actuator and the normal load, with the dissipation of the steady cycle.

Partial slip: the contact never slides as a whole. Mixed: it does before the steady cycle, and not
in it. Gross sliding: it does in every cycle. Friction has one coefficient here: the maps of rigs
whose friction grows from cycle to cycle (Vingsbo and Soderberg 1988) have a wider mixed regime.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import BodyEffects, InputError, LoadPath, Scene, read_only_copy, scene_of
from scenes.array_types import Array
from scenes.arrays import real_numbers
from semi_analytic.answer_of_rig import rigged_scene, slides_of
from semi_analytic.body_numbers import checked_effects
from semi_analytic.driven import DrivenPath, actuator_rows


class Regime(enum.IntEnum):
    """What a contact does in a cycle."""

    PARTIAL = 0
    MIXED = 1
    GROSS = 2


@dataclass(frozen=True, eq=False)
class FrettingMap:
    """The regime of each member, arrays of one shape.

    Attributes
    ----------
    regime
        `Regime` as int8
    dissipation
        W of the steady cycle [energy / thickness]
    slide
        distance that the contact slides as a whole in the steady cycle, forward and back [length]
    largest_tangential_load
        largest |Q| of the steady cycle [force / thickness]
    """

    regime: NDArray[np.int8]
    dissipation: Array
    slide: Array
    largest_tangential_load: Array


def fretting_map(
    scene: Scene,
    stroke: ArrayLike,
    normal_load: ArrayLike = 1.0,
    *,
    effects: BodyEffects | None = None,
) -> FrettingMap:
    """Fretting map of a rig: partial slip, mixed or gross sliding, with friction work and sliding
    distance, for factors of stroke and normal load.

    Mixed: the contact slides as a whole before the steady cycle, and not in it. Gross sliding: in
    every cycle.

    Parameters
    ----------
    scene
        a cycle with a prescribed tangential displacement
    stroke, normal_load
        factors of the displacement and of P, or of the approach, of the scene; they broadcast
    effects
        of the bodies, `halfplane_fe.body_effects(scene)`; of half-planes None

    Returns
    -------
    FrettingMap
        At constant P each stroke of the actuator, from one turning point to the next, is one step
        and leaves no step error; else a cycle has about 200 steps. The dissipation leaves out tilt,
        bulk strain and the next order of the bodies' compliance.

    Raises
    ------
    InputError
        For a scene of loads, or one that does not repeat; for factors that are not above 0; for a
        cycle that is not steady after `scene.cycles`.

    Examples
    --------
    >>> from scenes import PolygonLoad, load_scene
    >>> load = PolygonLoad(
    ...     initial_loading=[(90, 0)], cycle=[(90, 1e-3), (90, -1e-3)], tangential_displacement=True
    ... )
    >>> scene = load_scene("cattaneo-mindlin").vary(load=load, rig={"datum_length": 50.0})
    >>> fretting_map(scene, stroke=[0.5, 1.0, 2.0]).regime.tolist()
    [0, 0, 2]
    """
    scene = scene_of(scene)
    actuator_path = _repeated_path_of_actuators(scene)
    stroke_factors, load_factors = _factors_of_map(stroke, normal_load)
    # the scene with its normal contact and the compliance of contact, bodies and springs
    rig_and_contact = rigged_scene(scene, checked_effects(effects))
    most_cycles = max(scene.cycles, 2)
    # at the ends of steps: instant, P or normal approach, and displacement of the actuator
    actuator_steps = actuator_rows(actuator_path, most_cycles, one_step_at_constant_load=True)

    # follow each scaled path, up to its first steady cycle
    steady_cycles = []
    for stroke_factor, load_factor in zip(
        stroke_factors.ravel().tolist(), load_factors.ravel().tolist(), strict=True
    ):
        scaled_steps = actuator_steps._replace(
            load_or_approach=load_factor * actuator_steps.load_or_approach,
            displacement=stroke_factor * actuator_steps.displacement,
        )
        steady_cycle = _steady_cycle_of(rig_and_contact.driven_path_of_rows(scaled_steps))
        if steady_cycle is None:
            raise InputError(
                f"fretting_map: no steady cycle among the first {most_cycles} with stroke ="
                f" {stroke_factor:.6g}, normal_load = {load_factor:.6g}: raise cycles of the scene"
            )
        steady_cycles.append(steady_cycle)
    return _map_of_cycles(steady_cycles, stroke_factors.shape)


def _repeated_path_of_actuators(scene: Scene) -> LoadPath:
    """The motion of the actuators of a rig over time, which must repeat itself: displacement of the
    tangential actuator, and P or the normal approach.

    InputError where the scene states loads (it has no tangential displacement), or has no cycle.
    """
    if not scene.load.is_driven:
        raise InputError(
            "fretting_map: the scene states loads; a map needs load.tangential_displacement"
        )
    actuator_path = scene.load.path_of_actuators()
    if actuator_path.period is None:
        raise InputError("fretting_map: the path does not repeat; state a cycle")
    return actuator_path


def _factors_of_map(stroke: ArrayLike, normal_load: ArrayLike) -> tuple[Array, Array]:
    """Factors of the stroke and of the normal load as arrays of one shape, which they broadcast to.

    InputError for values that are no real numbers, and for factors that are not above 0.
    """
    factors = np.broadcast_arrays(
        np.array(real_numbers(stroke, "stroke")), np.array(real_numbers(normal_load, "normal_load"))
    )
    for name, factor in zip(("stroke", "normal_load"), factors, strict=True):
        if not np.all(factor > 0):
            raise InputError(f"fretting_map: {name} has {factor.min():.6g}: factors are above 0")
    return factors[0], factors[1]


class _SteadyCycle(NamedTuple):
    """The first steady cycle of one member of a fretting map.

    Attributes
    ----------
    regime
        partial slip, mixed or gross sliding
    dissipation
        friction work W of the cycle [energy / thickness]
    slide
        distance that the contact slides as a whole in the cycle, forward and back [length]
    largest_tangential_load
        largest |Q| of the cycle [force / thickness]
    """

    regime: Regime
    dissipation: float
    slide: float
    largest_tangential_load: float


def _steady_cycle_of(driven_path: DrivenPath) -> _SteadyCycle | None:
    """The first steady cycle of a path that actuators drive, with the regime of the contact; None
    where no cycle is steady.

    Gross sliding: the contact slides as a whole in that cycle. Mixed: it does before that cycle
    only. Else partial slip. A row of the path is an instant at the end of a step.
    """
    cycle_number = driven_path.first_steady_cycle
    if cycle_number is None:
        return None
    # row at which the cycle begins
    first_row = driven_path.end_rows[cycle_number]
    rows_of_cycle = slice(first_row, driven_path.end_rows[cycle_number + 1] + 1)
    # intervals of gross sliding in the steady cycle
    slides_of_cycle = slides_of(driven_path, rows_of_cycle)
    regime = Regime.PARTIAL
    if slides_of_cycle:
        regime = Regime.GROSS
    elif slides_of(driven_path, slice(0, first_row + 1)):
        regime = Regime.MIXED
    tangential_load = driven_path.followed_path.tangential_load[rows_of_cycle]
    return _SteadyCycle(
        regime=regime,
        dissipation=driven_path.work(rows_of_cycle),
        slide=sum(abs(slide.distance) for slide in slides_of_cycle),
        largest_tangential_load=np.max(np.abs(tangential_load)),
    )


def _map_of_cycles(steady_cycles: list[_SteadyCycle], shape: tuple[int, ...]) -> FrettingMap:
    """The fretting map, arrays of one `shape`, from the steady cycle of each of its members.

    The last index of the map runs fastest in the list.
    """

    def array_of(name: str, dtype: type) -> NDArray[Any]:
        """One value of all steady cycles, by its name, as a read-only array of the map's shape."""
        values = [getattr(steady_cycle, name) for steady_cycle in steady_cycles]
        return read_only_copy(np.array(values, dtype=dtype).reshape(shape), dtype)

    return FrettingMap(
        array_of("regime", np.int8),
        array_of("dissipation", float),
        array_of("slide", float),
        array_of("largest_tangential_load", float),
    )
