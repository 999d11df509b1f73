"""What tilt and bulk strain of finite bodies, which follow the loads, make of the dissipation.

The odd numbers of `BodyEffects` add to half-planes::

    tilt         alpha = alpha_P P + alpha_Q Q
    bulk strain  eps = e_P P + e_Q Q

What they make is known in the second order beside the memory curve (`odd_memory`), or on grids to
all orders. There half-planes are followed under such a path; the same grids follow P and Q alone,
so that most of their error leaves the ratio of both works. Curvatures of the bodies are not in it:
for those see `corrected`.

# notation: alpha tilt, eps strain of the lower face minus that of the upper one
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import BodyEffects, Combination, Estimate, InputError, LoadSegment, Scene
from scenes.body_effects import ZERO
from semi_analytic.answer import Question
from semi_analytic.answer_by_memory import by_memory
from semi_analytic.body_numbers import checked_effects
from semi_analytic.bulk_and_tilt import PathLoads, leaning_profile
from semi_analytic.elasticity import composite_modulus
from semi_analytic.grid import GridRequest, cycle_works, edges_along
from semi_analytic.odd_memory import ODD_NUMBERS, Declined, odd_answer

Array = NDArray[np.float64]

# On two bodies under four load cycles the change differed from that on cells half as large by at
# most 2.8e-4, and by 0.6 % of itself where it is above 5 %.
_OF_GRID = 3e-4
_OF_CHANGE = 0.01
# Segments of a path at most: each takes four increments of the grids or more.
_MOST_SEGMENTS = 60
_REQUEST = GridRequest(cells=80, increments=160, pointwise=False)


@dataclass(frozen=True, eq=False)
class FollowingLoads(PathLoads):
    """P and Q of a path, with the tilt and the bulk strain that the bodies make of them.

    Attributes
    ----------
    effects
        of the bodies; the odd numbers alone count
    """

    effects: BodyEffects

    def values(self, time: Array) -> Array:
        """P, Q, eps and alpha at times within one leg, (4, n)."""
        normal_load, tangential_load, _, _ = super().values(time)
        effects = self.effects
        strain = effects.strain_under_pressure.value * normal_load
        strain = strain + effects.strain_under_shear.value * tangential_load
        tilt = effects.tilt_under_pressure.value * normal_load
        tilt = tilt + effects.tilt_under_shear.value * tangential_load
        return np.stack([normal_load, tangential_load, strain, tilt])

    def turning_times(self, segment: LoadSegment) -> list[float]:
        """End of a segment of the load path and turning points of P, Q, bulk strain and tilt in it,
        one time for all that turn together.

        Strain and tilt are sums of what P and Q add, so that they may turn where neither load does.
        """
        different_times = super().turning_times(segment)
        effects = self.effects
        # what P and what Q add: to the bulk strain, to the tilt
        for effect_of_normal_load, effect_of_shear_load in (
            (effects.strain_under_pressure, effects.strain_under_shear),
            (effects.tilt_under_pressure, effects.tilt_under_shear),
        ):
            if not (effect_of_normal_load.value and effect_of_shear_load.value):
                continue  # turns where P or Q does
            for time in segment.turning_points(
                Combination(effect_of_normal_load.value, effect_of_shear_load.value)
            ):
                distance = min(abs(time - known_time) for known_time in different_times)
                if distance > 1e-6 * (segment.end - segment.start):
                    different_times.append(time)
        return different_times


def change_by_tilt_and_strain(scene: Scene, effects: BodyEffects) -> Estimate:
    """Relative change of the friction work W of half-planes by the tilt and bulk strain that finite
    bodies add: W with them over W without, minus 1.

    Of the last cycle, or of the whole path where none repeats. By the second order where that holds
    and is as good as the grids, in some 30 ms; else by grids, in a second or two. The uncertainty
    is that of the next order or of the grid, and of the numbers.

    Raises
    ------
    InputError
        For a scene that states bulk stress or tilt itself, unlike materials, a path of more than 60
        segments, a profile that bends down somewhere; where the grid does not converge.
    """
    if checked_effects(effects) is None:
        return ZERO
    if not any(getattr(effects, name).value for name in ODD_NUMBERS):
        return ZERO
    if scene.unsymmetric:
        raise InputError(
            "effects: their tilt and bulk strain are not taken beside bulk stress, tilt or unequal"
            " sides of the scene itself; take halfplane_fe.solve"
        )
    if effects.dundurs_beta:
        raise InputError(
            "effects: the materials are unlike (Dundurs' beta is not 0), and tilt and bulk strain"
            " count in the first order, which half-plane theory does not take; take"
            " halfplane_fe.solve"
        )
    second_order = _by_second_order(scene, effects)
    if second_order is not None and second_order.uncertainty <= _of_grids(second_order.value):
        return second_order
    return _by_grids(scene, effects)


def _of_grids(change: float) -> float:
    """Uncertainty of a change on grids, by the grids alone."""
    return _OF_GRID + _OF_CHANGE * abs(change)


def _by_second_order(scene: Scene, effects: BodyEffects) -> Estimate | None:
    """The change in the second order; None where that does not hold."""
    try:
        added = odd_answer(scene, effects).works[-1]
    except Declined:
        return None
    work = work_of_half_planes(scene)
    return Estimate(added.value / work, added.uncertainty / work) if work > 0 else None


def work_of_half_planes(scene: Scene) -> float:
    """W of half-planes under the scene's P and Q."""
    of_work = Question(scene, frozenset({"dissipation"}), np.zeros(1), None, "all", False, None)
    return float(by_memory(of_work, None).values["dissipation"])


def _by_grids(scene: Scene, effects: BodyEffects) -> Estimate:
    """Relative change of the friction work of half-planes by the tilt and bulk strain of finite
    bodies, by a numerical solution on grids: one path followed with them and without.

    InputError for a path of too many segments. `effects` hold tilt and strain per load, with their
    uncertainties.
    """
    path = scene.load.path()
    segments = len(path.initial_loading) + len(path.cycle)
    if segments > _MOST_SEGMENTS:
        raise InputError(
            f"load: grids take a path of {_MOST_SEGMENTS} segments at most, not {segments}; take a"
            " part of the path"
        )
    path_loads, profile = leaning_profile(scene)
    zeros: dict[str, Any] = dict.fromkeys(ODD_NUMBERS, ZERO)
    effects_without = replace(effects, **zeros)
    loads_with_and_without = []
    for odd_effects in (effects, effects_without):
        fields_of_path = {item.name: getattr(path_loads, item.name) for item in fields(path_loads)}
        loads_with_and_without.append(FollowingLoads(**fields_of_path, effects=odd_effects))
    edges = np.concatenate(
        [edges_along(course_loads, profile) for course_loads in loads_with_and_without]
    )
    span = (float(np.min(edges)), float(np.max(edges)))
    works_with_and_without = [
        cycle_works(
            course_loads,
            span,
            scene.profile.height,
            scene.friction.coefficient,
            composite_modulus(scene.material),
            _REQUEST,
        )
        for course_loads in loads_with_and_without
    ]
    change = (
        float(np.mean(works_with_and_without[0][:, -1]) / np.mean(works_with_and_without[1][:, -1]))
        - 1
    )
    relative_uncertainty = sum(
        abs(getattr(effects, name).uncertainty / getattr(effects, name).value)
        for name in ODD_NUMBERS
        if getattr(effects, name).value
    )
    # The change is of second order in the numbers.
    return Estimate(change, _of_grids(change) + 2 * relative_uncertainty * abs(change))
