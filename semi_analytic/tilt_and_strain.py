"""Change of the friction work by the tilt and bulk strain of finite bodies, which follow the loads.

The odd numbers of `BodyEffects`, tilt and bulk strain per load, add to half-planes::

    tilt         alpha = alpha_P P + alpha_Q Q
    bulk strain  eps = e_P P + e_Q Q

Their change of the work is known in the second order beside the memory curve (`odd_memory`), or on
grids to all orders. There half-planes are followed under such a path, and under P and Q alone on
the same grids, so that most of their error cancels in the ratio of both works. Curvatures of the
bodies are left out: for those see `corrected`.

# notation: alpha tilt, eps strain of the lower face minus that of the upper one
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from scenes import BodyEffects, Combination, Estimate, InputError, LoadSegment, Scene
from scenes.array_types import Array
from scenes.body_effects import ZERO_ESTIMATE
from scenes.frozen import validated
from semi_analytic.answer import Question
from semi_analytic.answer_by_memory import findings_by_memory
from semi_analytic.body_numbers import checked_effects
from semi_analytic.bulk_and_tilt import PathLoads, path_loads_and_contact
from semi_analytic.elasticity import composite_modulus
from semi_analytic.grid import GridRequest, contact_edges_along, cycle_works
from semi_analytic.odd_memory import TILT_AND_STRAIN_NAMES, DeclinedError, second_order_answer

# On two bodies under four load cycles the change differed from that on cells half as large by at
# most 2.8e-4, and by 0.6 % of itself where it is above 5 %.
_CHANGE_ERROR_OF_GRIDS = 3e-4
_GRID_ERROR_PER_CHANGE = 0.01
# Segments of a path at most: each takes four increments of the grids or more.
_MOST_SEGMENTS_ON_GRIDS = 60
_GRID_REQUEST = GridRequest(cells=80, increments=160, pointwise=False)


@dataclass(frozen=True, eq=False)
class FollowingLoads(PathLoads):
    """P and Q of a path, with the tilt and the bulk strain that finite bodies have under them.

    Attributes
    ----------
    effects
        of the bodies: of these tilt and bulk strain per load are used
    """

    effects: BodyEffects

    def loads_in_segment(self, time: Array) -> Array:
        """P, Q [force per thickness], bulk strain eps and tilt alpha [rad] at times (n,) within one
        segment of the load path, as rows of (4, n).

        Strain and tilt are those that the finite bodies have under P and Q: a number of `effects`
        per load times that load. Bulk stress and tilt of the scene itself are not taken.
        """
        normal_load, tangential_load, _, _ = super().loads_in_segment(time)
        effects = self.effects
        strain = effects.strain_under_pressure.value * normal_load
        strain = strain + effects.strain_under_shear.value * tangential_load
        tilt = effects.tilt_under_pressure.value * normal_load
        tilt = tilt + effects.tilt_under_shear.value * tangential_load
        return np.stack([normal_load, tangential_load, strain, tilt])

    def turning_times(self, segment: LoadSegment) -> list[float]:
        """Times in a segment of the load path at which P, Q, bulk strain or tilt turn, and the end
        of the segment; one time for all that turn together, within 1e-6 of the duration.

        Strain and tilt are sums of a multiple of P and one of Q: they may turn where neither does.
        """
        distinct_times = super().turning_times(segment)
        effects = self.effects
        # bulk strain, then tilt: by a unit of P and by a unit of Q
        for effect_of_normal_load, effect_of_shear_load in (
            (effects.strain_under_pressure, effects.strain_under_shear),
            (effects.tilt_under_pressure, effects.tilt_under_shear),
        ):
            if not (effect_of_normal_load.value and effect_of_shear_load.value):
                continue  # a multiple of one load turns where that does
            for time in segment.turning_points(
                Combination(effect_of_normal_load.value, effect_of_shear_load.value)
            ):
                time_to_nearest = min(abs(time - known_time) for known_time in distinct_times)
                if time_to_nearest > 1e-6 * (segment.end - segment.start):
                    distinct_times.append(time)
        return distinct_times


def change_by_tilt_and_strain(scene: Scene, effects: BodyEffects) -> Estimate:
    """Relative change of the friction work W of half-planes by the tilt and bulk strain that finite
    bodies add: W with them over W without, minus 1.

    W is that of the last cycle, or of the whole path where it has no cycle. It is expanded to the
    second order in tilt and strain per load where that is as accurate as grids, in some 30 ms. Else
    it is solved on grids, in a second or two. The uncertainty is that of the next order or of the
    grid, plus that of the numbers in `effects`. Change and uncertainty are 0 where `effects` have
    neither tilt nor strain.

    Parameters
    ----------
    scene
        profile, material, friction and load path
    effects
        tilt and bulk strain of the bodies per P and per Q, with their uncertainties

    Raises
    ------
    InputError
        For a scene that states bulk stress, tilt or unequal sides of the profile itself, unlike
        materials, loads under which half-planes do no friction work. Where grids are needed, also
        for a path of more than 60 segments, a profile that bends down somewhere, a grid that does
        not converge.
    """
    scene = validated(scene, Scene)
    # None where every number of `effects` is 0
    if checked_effects(effects) is None:
        return ZERO_ESTIMATE
    # TILT_AND_STRAIN_NAMES: attributes of `effects` with tilt under P and Q, strain under P and Q.
    if not any(getattr(effects, name).value for name in TILT_AND_STRAIN_NAMES):
        return ZERO_ESTIMATE
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
    work = work_of_half_planes(scene)
    if not work > 0:
        raise InputError(
            "load: nothing slips on half-planes, so that no change of the friction work could be"
            " stated as a share of it"
        )
    second_order = _change_by_second_order(scene, effects, work)
    if second_order is not None and second_order.uncertainty <= _uncertainty_of_grids(
        second_order.value
    ):
        return second_order
    return _change_by_grids(scene, effects)


def _uncertainty_of_grids(change: float) -> float:
    """Uncertainty of a relative change of work on grids, by the size of their cells alone."""
    return _CHANGE_ERROR_OF_GRIDS + _GRID_ERROR_PER_CHANGE * abs(change)


def _change_by_second_order(scene: Scene, effects: BodyEffects, work: float) -> Estimate | None:
    """Relative change of the friction work of the last cycle by tilt and bulk strain of finite
    bodies, to the second order in them; None where that does not hold. `work` > 0 is that of
    half-planes [energy per thickness].
    """
    try:
        # `works`: what tilt and strain add to the work of each cycle or path
        added_work = second_order_answer(scene, effects).works[-1]
    except DeclinedError:
        return None
    return Estimate(added_work.value / work, added_work.uncertainty / work)


def work_of_half_planes(scene: Scene) -> float:
    """Friction work W of half-planes under the scene's P and Q, of the last cycle, or of the whole
    path where it has none [energy per thickness].
    """
    question = Question(scene, frozenset({"dissipation"}), np.zeros(1), None, "all", False, None)
    return float(findings_by_memory(question, None).values["dissipation"])


def _change_by_grids(scene: Scene, effects: BodyEffects) -> Estimate:
    """Relative change of the friction work W of half-planes by the tilt and bulk strain of finite
    bodies: W with them over W without, minus 1, both solved step by step on the same grids.

    W is that of the last cycle followed, and must not be 0 without tilt and strain. InputError for
    a path of more than 60 segments. `effects` has tilt and bulk strain per load, with their
    uncertainties. The change is of second order in these numbers: it errs by twice the sum of their
    relative uncertainties.
    """
    path = scene.load.path()
    n_segments = len(path.initial_loading) + len(path.cycle)
    if n_segments > _MOST_SEGMENTS_ON_GRIDS:
        raise InputError(
            f"load: grids take a path of {_MOST_SEGMENTS_ON_GRIDS} segments at most, not"
            f" {n_segments}; take a part of the path"
        )
    # TILT_AND_STRAIN_NAMES: attributes with tilt under P and Q, strain under P and Q.
    no_tilt_nor_strain: dict[str, Any] = dict.fromkeys(TILT_AND_STRAIN_NAMES, ZERO_ESTIMATE)
    effects_without_tilt_and_strain = replace(effects, **no_tilt_nor_strain)
    work_with_tilt_and_strain, work_without_tilt_and_strain = _works_on_same_grids(
        scene, [effects, effects_without_tilt_and_strain]
    )
    change = work_with_tilt_and_strain / work_without_tilt_and_strain - 1

    # Sum of the relative uncertainties of those numbers that are not 0.
    relative_uncertainty = sum(
        abs(getattr(effects, name).uncertainty / getattr(effects, name).value)
        for name in TILT_AND_STRAIN_NAMES
        if getattr(effects, name).value
    )
    return Estimate(change, _uncertainty_of_grids(change) + 2 * relative_uncertainty * abs(change))


def _works_on_same_grids(scene: Scene, effects_of_bodies: list[BodyEffects]) -> list[float]:
    """Friction works W of the last cycle, or of a path without cycle, one for each entry of
    `effects_of_bodies` [energy per thickness].

    An entry is tilt and bulk strain per load of one pair of bodies; P and Q are those of the scene.
    All are solved on the same grids, so that most of their error cancels in a ratio of two works. W
    is the mean over grids that are moved by fractions of a cell.
    """
    # P and Q of the scene over time, and its normal contact as a function of load and tilt
    path_loads, tilted_contact = path_loads_and_contact(scene)
    fields_of_path_loads = {
        load_field.name: getattr(path_loads, load_field.name) for load_field in fields(path_loads)
    }
    loads_of_bodies = [
        FollowingLoads(**fields_of_path_loads, effects=effects) for effects in effects_of_bodies
    ]
    contact_edges = np.concatenate(
        [contact_edges_along(loads, tilted_contact) for loads in loads_of_bodies]
    )
    outermost_edges = (float(np.min(contact_edges)), float(np.max(contact_edges)))
    return [
        float(np.mean(_last_works_on_grids(scene, loads, outermost_edges)))
        for loads in loads_of_bodies
    ]


def _last_works_on_grids(
    scene: Scene, loads: PathLoads, outermost_edges: tuple[float, float]
) -> Array:
    """Friction work W of the last cycle under given loads, or of a path without cycle, by each of g
    grids, (g,) [energy per thickness]. The grids are moved by fractions of a cell.

    `loads` are P, Q, bulk strain and tilt over time. The grids cover the contact between its
    `outermost_edges` along the path, x on the left and on the right [length].
    """
    # (g, c) of all c cycles, until one repeats the one before; 80 cells across the contact
    works_of_cycles = cycle_works(
        loads,
        outermost_edges,
        scene.profile.height,
        scene.friction.coefficient,
        composite_modulus(scene.material),
        _GRID_REQUEST,
    )
    return np.asarray(works_of_cycles[:, -1])
