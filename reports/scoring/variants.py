"""Half-plane theory of a scene with faults in it: the tractions that a result with just these
faults has.

A `Variant` is solved and then transformed as a file is: places, factors, sign. Two faults at once
are one `Variant` as well.

# notation: P, Q loads, p pressure, q shear, f friction coefficient, a half-width, E* modulus
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.scoring.cells import pressure_on_layer, shear_by_coupling
from reports.scoring.discrepancy import (
    PRESSURE,
    SHEAR,
    Discrepancy,
    Tractions,
    factors_of_tractions,
    fraction_of_cycle,
)
from scenes import (
    BodyEffects,
    Estimate,
    InputError,
    LineOfAction,
    Materials,
    PolygonLoad,
    Scene,
    Wave,
    WaveSum,
)
from scenes.array_types import Array
from semi_analytic.bulk_and_tilt import one_curve
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import contact_of

# Number of the cycle, from 0 on, at which delayed instants are looked up: after two cycles all
# paths of the library repeat.
_STEADY_CYCLE = 2
# Points between two nodes at which theory is averaged.
_POINTS_BETWEEN_NODES = 48
# Height of the two blocks [a_ref] whose curvatures, times a factor, are those of bodies too small:
# curvatures go as one over the square of the height.
BLOCK_HEIGHT = 5.0
# Curvature of the gap per P, and of the tangential displacement per Q, of two blocks twice as wide
# as high: `halfplane_fe.body_effects` gives these of A/H^2 for any height H, with A = 2/E* and
# nu = 0.3.
_NORMAL_CURVATURE = 0.4918
_TANGENTIAL_CURVATURE = 0.8069
# Steps of a revolution that cells follow: legs of two, three or four a cycle end on them.
_STEPS_A_CYCLE = 24
# Loads that differ by less than this share of the largest P are equal: those of one cycle and the
# next differ by rounding.
_DIFFERENCE_OF_SAME_LOADS = 1e-9


@dataclass(frozen=True)
class Variant:
    """Half-plane theory of the scene with faults in it; as it stands, it has none.

    Attributes
    ----------
    modulus_factor, friction_factor
        factors of E* and f
    delay
        share of a period by which the tractions are late
    wrong_load
        the key of a bulk stress or tilt that is turned or left out
    history_fault
        "first revolution", "no memory", "straight steps", "end of steps": what is done to the
        history of friction
    share_of_block_curvatures
        share of the curvatures that two blocks of height `BLOCK_HEIGHT` a_ref add
    relative_layer_compliance
        compliance of a layer that the faces sink into by p/k, 1/k over a_ref/E*; it acts on the
        pressure, and the shear stays that of theory
    dundurs_beta
        Dundurs' constant of the bodies
    takes_odd_part
        whether the part of the tractions that is odd in x is taken from the result
    has_nodal_forces
        whether tractions are nodal forces over the spacing
    x_stretch, x_offset
        x of the file is stretch x + offset a_ref
    pressure_factor, shear_factor
        of the tractions in the file
    is_swapped
        whether pressure and shear are exchanged
    """

    modulus_factor: float = 1.0
    friction_factor: float = 1.0
    delay: float = 0.0
    wrong_load: str = ""
    history_fault: str = ""
    share_of_block_curvatures: float = 0.0
    relative_layer_compliance: float = 0.0
    dundurs_beta: float = 0.0
    takes_odd_part: bool = False
    has_nodal_forces: bool = False
    x_stretch: float = 1.0
    x_offset: float = 0.0
    pressure_factor: float = 1.0
    shear_factor: float = 1.0
    is_swapped: bool = False


@dataclass(frozen=True, eq=False)
class Predictions:
    """Tractions of variants at the points and instants of a discrepancy, each solved once."""

    discrepancy: Discrepancy
    tractions_by_variant: dict[tuple[Variant, bool], Tractions] = field(default_factory=dict)

    def tractions_of(self, variant: Variant, *, with_shear: bool = True) -> Tractions:
        """Pressure p and shear q, (2, k, n), at the n points and k instants of a result, if it had
        the faults of `variant`: a wrong modulus, factors of the file's pressure and shear, p and q
        swapped, and others. Each variant is solved by half-plane theory once.

        Unless `with_shear` q is the reference's: the pressure alone needs no history of friction,
        and is solved in a tenth of the time.

        Raises
        ------
        InputError
            Where theory has no such solution: gross sliding, separation. Also where friction has to
            be followed at a grid of points, which takes seconds: too long for a search.
        """
        # faults of the file alone are applied below, and need no solve
        solved_variant = replace(
            variant, pressure_factor=1.0, shear_factor=1.0, is_swapped=False, takes_odd_part=False
        )
        needs_shear = with_shear or variant.is_swapped
        if (solved_variant, needs_shear) not in self.tractions_by_variant:
            self.tractions_by_variant[solved_variant, needs_shear] = self._solved_tractions(
                solved_variant, with_shear=needs_shear
            )
        tractions = self.tractions_by_variant[solved_variant, needs_shear]
        if variant.is_swapped:
            tractions = tractions[::-1]
        # pressure and shear times the factors of the file
        tractions = factors_of_tractions(variant.pressure_factor, variant.shear_factor) * tractions
        # a stand-in for unlike bodies: the part of the difference that is odd in x
        if variant.takes_odd_part:
            difference = self.discrepancy.result_tractions - tractions
            tractions = tractions + self._odd_part(difference, variant.x_offset)
        return tractions

    def _odd_part(self, difference: Tractions, offset: float) -> Tractions:
        """The part of a difference (2, k, n) between result and theory that is odd about the centre
        of the contact, x = `offset` a_ref: half of the difference minus its mirror image.

        Between like, symmetric bodies nothing is odd, whatever the loads and the history.
        """
        x = self.discrepancy.x
        mirrored_x = 2 * offset * self.discrepancy.half_width - x
        mirrored_difference = np.apply_along_axis(
            lambda values: np.interp(mirrored_x, x, values), 2, difference
        )
        return (difference - mirrored_difference) / 2

    def _solved_tractions(self, variant: Variant, *, with_shear: bool) -> Tractions:
        """Pressure p and shear q of half-plane theory with faults put in, (2, k, n), at the n
        points of a result and k instants. `variant` states the faults, such as other times or a
        coarse mesh. The points are shifted or stretched where that is among the faults.

        Where the reference is not theory itself its difference from theory is added. Without
        `with_shear` only the pressure is solved, and q is the reference's.
        """
        # a variant without any fault
        if variant == Variant():
            return self.discrepancy.reference_tractions
        x_with_faults = (
            self.discrepancy.x - variant.x_offset * self.discrepancy.half_width
        ) / variant.x_stretch
        # nodal forces over element lengths, in place of tractions at the points
        if variant.has_nodal_forces:
            # m points between the n nodes, and weights (m, n) by which tractions at these points
            # are summed to nodal forces over lengths
            fine_points, weights = _shape_functions(x_with_faults)
            tractions = (
                self._tractions_of_theory(variant, fine_points, with_shear=with_shear) @ weights
            )
        else:
            tractions = self._tractions_of_theory(variant, x_with_faults, with_shear=with_shear)
        # a reference that is not half-plane theory itself
        if not self.discrepancy.is_half_plane_theory:
            # theory without faults
            theory = self._tractions_of_theory(Variant(), self.discrepancy.x, with_shear=with_shear)
            tractions = tractions + (
                self.discrepancy.reference_tractions[: len(tractions)] - theory
            )
        if not with_shear:
            tractions = np.array([tractions[PRESSURE], self.discrepancy.reference_tractions[SHEAR]])
        return tractions

    def _tractions_of_theory(self, variant: Variant, x: Array, *, with_shear: bool) -> Tractions:
        """Pressure p of half-plane theory with faults put in at points x (n,), and shear q if
        `with_shear`: (1 or 2, k, n) at k instants. `variant` holds the size of each fault: no
        memory of friction, long load steps, small bodies, a soft normal contact, unlike materials
        (Dundurs' beta).

        Factors, swaps and offsets of the file are applied later. InputError where the contact
        slides or separates, and where friction would have to be followed at a grid of points.

        # notation: a_ref half-width of contact of the reference, E* composite modulus, P normal
        #           load, Q tangential load
        """
        # scene with another modulus, friction or load; times (k,) earlier by a delay, or of the
        # first cycle
        discrepancy = self.discrepancy
        scene_with_faults = self._scene_with_faults(variant)
        time = self._times_with_faults(variant, scene_with_faults)
        if variant.history_fault == "no memory" and with_shear:
            return _tractions_without_memory(scene_with_faults, x, time)
        if variant.history_fault in ("straight steps", "end of steps") and with_shear:
            takes_ends = variant.history_fault == "end of steps"
            return _tractions_by_long_steps(
                discrepancy, scene_with_faults, x, takes_ends=takes_ends
            )

        # small bodies: curvatures that blocks of finite height add to half-planes
        effects = None
        if variant.share_of_block_curvatures < 0 or variant.relative_layer_compliance < 0:
            raise InputError("a body of negative height, a layer of negative compliance")
        if variant.share_of_block_curvatures:
            effects = _curvatures_of_blocks(
                discrepancy, scene_with_faults, variant.share_of_block_curvatures
            )
        # the pressure alone, with a soft layer, whose compliance is relative to a_ref/E*
        if not with_shear:
            layer_compliance = (
                variant.relative_layer_compliance
                * discrepancy.half_width
                / composite_modulus(discrepancy.scene.material)
            )
            return self._pressure(scene_with_faults, x, time, effects, layer_compliance)[None]
        # faces that sink into each other: a soft layer changes the pressure alone
        if variant.relative_layer_compliance:
            pressure = self._tractions_of_theory(variant, x, with_shear=False)[PRESSURE]
            variant_without_layer = replace(variant, relative_layer_compliance=0.0)
            return np.array(
                [
                    pressure,
                    self._tractions_of_theory(variant_without_layer, x, with_shear=True)[SHEAR],
                ]
            )
        # one_curve: the scene as one memory curve of all flat punches; None where bulk stress or
        # tilt needs a grid of points
        if scene_with_faults.unsymmetric and one_curve(scene_with_faults) is None:
            raise InputError("its memory of friction is no one curve: not looked for")
        tractions = _tractions_of_scene(scene_with_faults, x, time, effects=effects)
        if variant.dundurs_beta:
            # (P, Q) of fine steps, and the step of each instant
            loads, step_numbers = _fine_load_steps(scene_with_faults, time)
            tractions[SHEAR] += shear_by_coupling(
                scene_with_faults, x, loads, step_numbers, variant.dundurs_beta
            )
        return tractions

    def _scene_with_faults(self, variant: Variant) -> Scene:
        """The scene with the wrong load, modulus E* and friction coefficient of a `variant`. Its
        `wrong_load` names a load that is turned or left out, "" for none; the factors are 1 without
        a fault.
        """
        scene = self.discrepancy.scene
        if variant.wrong_load:
            scene = scene.vary(load=wrong_loads(scene)[variant.wrong_load])
        if variant.modulus_factor != 1.0:
            scene = scene_with_modulus_factor(scene, variant.modulus_factor)
        if variant.friction_factor != 1.0:
            scene = scene_with_friction(scene, variant.friction_factor * scene.friction.coefficient)
        return scene

    def _times_with_faults(self, variant: Variant, scene: Scene) -> Array:
        """Times of the load path, (k,), whose tractions a result with the faults of `variant` has
        at its k instants: earlier by a delay, or in the first cycle in place of the steady one.
        """
        discrepancy = self.discrepancy
        path = scene.load.path()
        if variant.history_fault == "first revolution":
            assert path.period is not None
            # cycle_fraction (k,): share of a period since the start of the cycle, up to 2
            fraction_in_cycle = np.where(
                discrepancy.cycle_fraction > 1,
                discrepancy.cycle_fraction - 1,
                discrepancy.cycle_fraction,
            )
            return path.cycle_start + np.minimum(fraction_in_cycle, 1 - 1e-12) * path.period
        if variant.delay:
            assert path.period is not None
            # looked up in the third cycle, by which all paths are steady
            fraction = np.mod(discrepancy.cycle_fraction - variant.delay, 1.0)
            return path.cycle_start + (_STEADY_CYCLE + fraction) * path.period
        return discrepancy.time

    def _pressure(
        self,
        scene: Scene,
        x: Array,
        time: Array,
        effects: BodyEffects | None,
        layer_compliance: float,
    ) -> Array:
        """(k, n) pressure p of half-plane theory at points x (n,) and times (k,); it depends on P
        alone where nothing tilts the contact. `effects` is what finite bodies add to half-planes;
        `layer_compliance` is that of a layer into which the faces sink by p times it
        [length/stress], used where p depends on P alone.

        # notation: P normal load
        """
        # is_driven: displacements are imposed in place of loads
        if effects is not None or scene.load.is_driven or self.discrepancy.comparison.may_tilt:
            return _tractions_of_scene(scene, x, time, effects=effects, fields=("pressure",))[
                PRESSURE
            ]
        normal_load = np.asarray(scene.load.path().at(time)[0])
        # closed form of the profile: pressure at x under any load
        contact = contact_of(scene.profile, scene.material)
        if layer_compliance:
            return pressure_on_layer(scene, x, normal_load, layer_compliance)
        return contact.pressure(x, normal_load[:, None])


def _shape_functions(nodes: Array) -> tuple[Array, Array]:
    """Points on linear elements, (m,), and weights (m, n) that make nodal forces of the tractions
    there: the sum of traction times weight is the force of a node, over the length that belongs to
    it. `nodes` (n,) are the x of the n nodes. 48 points lie between two nodes.

    The weight is the node's hat function at the point, 1 at the node and 0 at both neighbours,
    times the length of the point over that of the node.
    """
    spacings = np.diff(nodes)
    spacing_before = np.concatenate([spacings[:1], spacings])
    spacing_after = np.concatenate([spacings, spacings[-1:]])
    # an element more beyond the first and the last node
    element_ends = np.concatenate(
        [[nodes[0] - spacing_before[0]], nodes, [nodes[-1] + spacing_after[-1]]]
    )
    element_lengths = np.diff(element_ends)
    share_of_spacing = np.arange(_POINTS_BETWEEN_NODES) / _POINTS_BETWEEN_NODES
    points = (element_ends[:-1, None] + element_lengths[:, None] * share_of_spacing).ravel()
    distance = points[:, None] - nodes
    relative_distance = np.where(distance > 0, distance / spacing_after, -distance / spacing_before)
    # the hat function of each node at each point
    shape_values = np.maximum(1 - relative_distance, 0.0)
    lengths_of_points = np.repeat(element_lengths / _POINTS_BETWEEN_NODES, _POINTS_BETWEEN_NODES)
    lengths_of_nodes = (spacing_before + spacing_after) / 2
    return points, shape_values * lengths_of_points[:, None] / lengths_of_nodes


def _tractions_of_scene(
    scene: Scene,
    x: Array,
    time: Array,
    *,
    effects: BodyEffects | None = None,
    straight_steps: bool = False,
    fields: tuple[str, ...] = ("pressure", "shear"),
) -> Tractions:
    """Pressure p and shear q of half-plane theory at points x and at times in any order, (2, k, n).
    With `straight_steps` the load path is straight between the times; `effects` is what finite
    bodies add to half-planes; of `fields` those not named are NaN.
    """
    distinct_times, rows_of_instants = np.unique(time, return_inverse=True)
    solution = semi_analytic.solve(
        scene,
        x=x,
        time=distinct_times,
        fields=fields,
        effects=effects,
        straight_steps=straight_steps,
    )
    return np.array([solution.pressure[rows_of_instants], solution.shear[rows_of_instants]])


def _fine_load_steps(scene: Scene, times: Array) -> tuple[Array, NDArray[np.intp]]:
    """Loads P and Q at the ends of n fine load steps along the load path, (n, 2), and for each of
    the `times` (k,) the number of the step that ends there. The steps go up to the end of the
    second cycle, to which times of a cycle are moved, since it is steady; along a path that does
    not repeat, up to the last of the times.
    """
    path = scene.load.path()
    if path.period is None:
        times_on_steps = times
        step_times = np.linspace(path.start, times.max(), 2 * _STEPS_A_CYCLE)
    else:
        cycle_fraction = np.mod((times - path.cycle_start) / path.period, 1.0)
        times_on_steps = path.cycle_start + path.period * (1 + cycle_fraction)
        # 8 steps of the initial loading, 24 of each of two cycles
        step_times = np.concatenate(
            [
                np.linspace(path.start, path.cycle_start, _STEPS_A_CYCLE // 3 + 1),
                path.cycle_start + path.period * np.linspace(0, 2, 2 * _STEPS_A_CYCLE + 1),
            ]
        )
    loaded_times = step_times[step_times > path.start]  # at the start nothing touches
    step_times = np.unique(np.concatenate([loaded_times, times_on_steps]))
    return np.transpose(path.at(step_times)), np.searchsorted(step_times, times_on_steps)


def _curvatures_of_blocks(discrepancy: Discrepancy, scene: Scene, share: float) -> BodyEffects:
    """Curvatures that two equal blocks of height 5 a_ref (`BLOCK_HEIGHT`) add to half-planes, times
    `share`: of the gap per P, and of the tangential displacement per Q. `half_width` is a_ref.

    # notation: a_ref half-width of contact of the reference, E* composite modulus, P normal load, Q
    #           tangential load
    """
    height = BLOCK_HEIGHT * discrepancy.half_width
    # A/H^2, with A = 2/E* (scales.compliance) and the height H
    curvature_unit = share * discrepancy.comparison.scales.compliance / height**2
    return BodyEffects(
        datum_length=scene.profile.datum_length,
        # Estimate: a value with its uncertainty, here none; factors of two blocks twice as wide
        # as high
        normal_curvature=Estimate(_NORMAL_CURVATURE * curvature_unit),
        tangential_curvature=Estimate(_TANGENTIAL_CURVATURE * curvature_unit),
    )


def _tractions_without_memory(scene: Scene, x: Array, time: Array) -> Tractions:
    """Pressure p and shear q, (2, k, n), at points x and at the given times, without memory of
    earlier loads. Each load acts as if it were the first one (Cattaneo): q = sign(Q) f [p(x, P) -
    p(x, P - |Q|/f)].

    Raises
    ------
    InputError
        Where the contact slides as a whole.

    # notation: f coefficient of friction, P normal load, Q tangential load
    """
    friction_coefficient = scene.friction.coefficient
    loads = scene.load.path().at(time)
    normal_load = np.asarray(loads[0])[:, None]
    tangential_load = np.asarray(loads[1])[:, None]
    stick_load = normal_load - np.abs(tangential_load) / friction_coefficient
    if not np.all(stick_load > 0):
        raise InputError("the loads slide")
    # closed form of the profile: pressure at x under any load
    contact = contact_of(scene.profile, scene.material)
    pressure = contact.pressure(x, normal_load)
    shear = (
        np.sign(tangential_load)
        * friction_coefficient
        * (pressure - contact.pressure(x, stick_load))
    )
    return np.array([pressure, shear])


def _tractions_by_long_steps(
    discrepancy: Discrepancy, scene: Scene, x: Array, *, takes_ends: bool
) -> Tractions:
    """Pressure p and shear q of half-plane theory, (2, k, n), if the result's own load increments
    replace the load path: by straight lines in the plane of P and Q, or (`takes_ends`) as a solver
    takes them that meets the Coulomb law at their ends.

    `discrepancy` holds the tractions of result and reference, and its k instants; `x` (n,) are the
    points.

    # notation: P normal load, Q tangential load
    """
    # ascending times at which the increments end; indices of the k instants among them
    times, rows_of_instants = _ends_of_increments(discrepancy, scene)
    if not takes_ends:
        return _tractions_of_scene(scene, x, times, straight_steps=True)[:, rows_of_instants]
    # vertices (P, Q) of the path that such a solver follows; times on it at which increments end
    polygon, polygon_times = _polygon_with_ends(scene, times)
    scene_of_polygon = scene.vary(load=PolygonLoad(initial_loading=tuple(polygon[1:])))
    return _tractions_of_scene(scene_of_polygon, x, np.array(polygon_times)[rows_of_instants])


def _ends_of_increments(discrepancy: Discrepancy, scene: Scene) -> tuple[Array, NDArray[np.intp]]:
    """Times on the scene's load path at which the load increments of a result end, ascending; and
    the indices among them of the k instants that are compared, (k,).

    The times are those of all instants of the result up to the end of its last cycle. Where it
    holds the cycle alone, they are the initial loading in eight steps, and this cycle twice.
    """
    path = scene.load.path()
    assert path.period is not None
    result_cycle = discrepancy.comparison.result_cycle
    times_of_result = discrepancy.comparison.result.time
    times = times_of_result[times_of_result <= result_cycle.time[-1]]
    times_of_instants = discrepancy.time
    if times_of_result[0] > path.cycle_start:
        # share of a period at each instant of the last cycle
        fractions_of_cycle = fraction_of_cycle(discrepancy.comparison)
        times_of_cycles = [
            path.cycle_start + (n_cycles_before + fractions_of_cycle) * path.period
            for n_cycles_before in (0, 1)
        ]
        times = np.concatenate([np.linspace(path.start, path.cycle_start, 9), *times_of_cycles])
        times_of_instants = path.cycle_start + (1 + discrepancy.cycle_fraction) * path.period
    times = np.unique(times[times > path.start])
    return times, np.abs(times[:, None] - times_of_instants).argmin(axis=0)


def _polygon_with_ends(scene: Scene, times: Array) -> tuple[list[tuple[float, float]], list[float]]:
    """Vertices (P, Q) of the load path that a solver follows in effect whose increments meet the
    Coulomb law at their ends, from (0, 0) on; and for each increment the number of the vertex at
    its end, which is the time on the polygon.

    While P rises such an increment is that of P first, and then that of Q at the new P; while P
    falls it is a straight line. Finite elements in increments that end on no event follow it to
    0.983 of the difference from theory at 48 increments a cycle, to 0.9999 at 4.

    `times` are those of the scene's path at which the increments end.

    # notation: P normal load, Q tangential load
    """
    loads_at_ends = scene.load.path().at(times)
    polygon = [(0.0, 0.0)]
    polygon_times = []
    least_change = _DIFFERENCE_OF_SAME_LOADS * float(np.max(loads_at_ends[0]))
    for normal_load, tangential_load in np.transpose(loads_at_ends).tolist():
        corner = (normal_load, polygon[-1][1])
        end_of_increment = (normal_load, tangential_load)
        is_rising = normal_load > polygon[-1][0]
        for vertex in (corner, end_of_increment) if is_rising else (end_of_increment,):
            normal_change = abs(vertex[0] - polygon[-1][0])
            tangential_change = abs(vertex[1] - polygon[-1][1])
            if max(normal_change, tangential_change) > least_change:
                polygon.append(vertex)
        polygon_times.append(float(len(polygon) - 1))  # a polygon takes one unit of time a segment
    return polygon, polygon_times


# ---------------------------------------------------------------------------- changes of a scene
def scene_with_modulus_factor(scene: Scene, factor: float) -> Scene:
    """The scene with E* times `factor`: both Young's moduli are multiplied."""
    upper, lower = (
        body.vary(young_modulus=factor * body.young_modulus)
        for body in (scene.material.upper, scene.material.lower)
    )
    return scene.vary(material=Materials(upper=upper, lower=lower))


def scene_with_friction(scene: Scene, coefficient: float) -> Scene:
    """The scene with another f."""
    return scene.vary(friction=coefficient)


def wrong_loads(scene: Scene) -> dict[str, dict[str, Any]]:
    """Changes of the scene's load that are likely faults of a result: bulk stress, or tilt, of the
    other sign, or left out. Returns name of the fault ("bulk_sign", "tilt_left_out", ...) ->
    changed entries of the load; None for an entry that is left out.
    """
    changes_by_fault = {}
    for name, keys in (
        ("bulk", ("bulk_stress_lower", "bulk_stress_upper")),
        ("tilt", ("tilt", "moment", "line_of_action")),
    ):
        stated_values = {
            key: value for key in keys if (value := getattr(scene.load, key)) is not None
        }
        if stated_values:
            changes_by_fault[f"{name}_sign"] = {
                key: _with_other_sign(value) for key, value in stated_values.items()
            }
            changes_by_fault[f"{name}_left_out"] = dict.fromkeys(stated_values)
    return changes_by_fault


def _with_other_sign(value: Any) -> Any:
    """A bulk stress, tilt or moment of the other sign, in the form that it was stated in: a number,
    numbers, a function of time, a wave or sum of waves with mean, phase [degrees] and initial
    loading, or a line of action of the loads.

    >>> (
    ...     _with_other_sign(0.5),
    ...     _with_other_sign((0.0, 2.0)),
    ...     _with_other_sign(LineOfAction(x=1.0, height=3.0)),
    ... )
    (-0.5, (-0.0, -2.0), LineOfAction(x=-1.0, height=-3.0))
    """
    match value:
        case Wave():
            # half a period later or earlier: the other sign of a sinusoid
            phase = value.phase_degrees + (180 if value.phase_degrees <= 0 else -180)
            return value.vary(
                mean=-value.mean,
                phase_degrees=phase,
                initial_loading=_with_other_sign(value.initial_loading),
            )
        case WaveSum():
            waves = tuple((amplitude, phase + 180) for amplitude, phase in value.harmonics)
            return value.vary(
                mean=-value.mean,
                harmonics=waves,
                initial_loading=_with_other_sign(value.initial_loading),
            )
        case LineOfAction():
            return value.vary(x=-value.x, height=-value.height)
        case tuple():
            return tuple(-number for number in value)
        # a function of time
        case _ if callable(value):
            return lambda time: -value(time)
    return -value
