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
    fraction_of_cycle,
    pair,
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

# Revolution of the steady cycle on which delayed instants are looked up: after two all paths of the
# library repeat.
_STEADY = 2
# Places between two nodes at which theory is averaged.
_BETWEEN_NODES = 48
# Height of the two blocks [a_ref] whose numbers, times their figure, are those of bodies too small:
# curvatures go as one over the square of the height.
BLOCK_HEIGHT = 5.0
# Curvature of the gap per P, and of the tangential displacement per Q, of two blocks twice as wide
# as high: `halfplane_fe.body_effects` gives these of A/H^2 for any height H, with A = 2/E* and
# nu = 0.3.
_NORMAL_CURVATURE = 0.4918
_TANGENTIAL_CURVATURE = 0.8069
# Steps of a revolution that cells follow: legs of two, three or four a cycle end on them.
_STEPS_A_CYCLE = 24
# Loads that differ by less than this share of the largest P are one: those of one revolution and
# the next differ by rounding.
_SAME_LOAD = 1e-9


@dataclass(frozen=True)
class Variant:
    """Half-plane theory of the scene with faults in it; as it stands, it has none.

    Attributes
    ----------
    stiffness, friction
        factors of E* and f
    delay
        share of a period by which the tractions are late
    wrong_load
        the key of a bulk stress or tilt that is turned or left out
    history
        "first revolution", "no memory", "straight steps", "end of steps": what is done to the
        history of friction
    small_body
        share of the curvatures that two blocks of height `BLOCK_HEIGHT` a_ref add
    soft_normal
        compliance of a layer that the faces sink into by p/k, 1/k over a_ref/E*; it acts on the
        pressure, and the shear stays that of theory
    beta
        Dundurs' constant of the bodies
    odd
        whether all is changed that is odd in x
    on_mesh
        whether tractions are nodal forces over the spacing
    stretch, offset
        x of the file is stretch x + offset a_ref
    pressure_factor, shear_factor
        of the tractions in the file
    swapped
        whether pressure and shear are exchanged
    """

    stiffness: float = 1.0
    friction: float = 1.0
    delay: float = 0.0
    wrong_load: str = ""
    history: str = ""
    small_body: float = 0.0
    soft_normal: float = 0.0
    beta: float = 0.0
    odd: bool = False
    on_mesh: bool = False
    stretch: float = 1.0
    offset: float = 0.0
    pressure_factor: float = 1.0
    shear_factor: float = 1.0
    swapped: bool = False


@dataclass(frozen=True, eq=False)
class Predictions:
    """Tractions of variants at the points and instants of a discrepancy, each solved once."""

    discrepancy: Discrepancy
    solved: dict[tuple[Variant, bool], Tractions] = field(default_factory=dict)

    def of(self, variant: Variant, *, sheared: bool = True) -> Tractions:
        """(2, k, n): p and q that a result with these faults has; q is the expected one unless
        `sheared`.

        The pressure alone needs no history of friction, and is solved in a tenth of the time.

        Raises
        ------
        InputError
            Where there is no such solution: gross sliding, separation; and where it takes a grid,
            whose seconds are too many for a search.
        """
        question = replace(variant, pressure_factor=1.0, shear_factor=1.0, swapped=False, odd=False)
        needs_shear = sheared or variant.swapped
        if (question, needs_shear) not in self.solved:
            self.solved[question, needs_shear] = self._solved(question, sheared=needs_shear)
        tractions = self.solved[question, needs_shear]
        if variant.swapped:
            tractions = tractions[::-1]
        tractions = pair(variant.pressure_factor, variant.shear_factor) * tractions
        if variant.odd:
            tractions = tractions + self._odd_part(
                self.discrepancy.found - tractions, variant.offset
            )
        return tractions

    def _odd_part(self, difference: Tractions, offset: float) -> Tractions:
        """Half of a difference minus its mirror image about the centre of the contact.

        Between like, symmetric bodies nothing is odd, whatever the loads and the history.
        """
        x = self.discrepancy.x
        mirrored_x = 2 * offset * self.discrepancy.half_width - x
        mirrored = np.apply_along_axis(lambda row: np.interp(mirrored_x, x, row), 2, difference)
        return (difference - mirrored) / 2

    def _solved(self, variant: Variant, *, sheared: bool) -> Tractions:
        if variant == Variant():
            return self.discrepancy.expected
        x = (self.discrepancy.x - variant.offset * self.discrepancy.half_width) / variant.stretch
        if variant.on_mesh:
            fine, weights = _shape_functions(x)
            tractions = self._theory(variant, fine, sheared=sheared) @ weights
        else:
            tractions = self._theory(variant, x, sheared=sheared)
        if not self.discrepancy.exact:
            theory = self._theory(Variant(), self.discrepancy.x, sheared=sheared)
            tractions = tractions + (self.discrepancy.expected[: len(tractions)] - theory)
        if not sheared:
            tractions = np.array([tractions[PRESSURE], self.discrepancy.expected[SHEAR]])
        return tractions

    def _theory(self, variant: Variant, x: Array, *, sheared: bool) -> Tractions:
        """p, and q if `sheared`, at x, before the file's own faults."""
        discrepancy = self.discrepancy
        scene = discrepancy.scene
        if variant.wrong_load:
            scene = scene.vary(load=wrong_loads(scene)[variant.wrong_load])
        if variant.stiffness != 1.0:
            scene = stiffer(scene, variant.stiffness)
        if variant.friction != 1.0:
            scene = with_friction(scene, variant.friction * scene.friction.coefficient)
        path = scene.load.path()
        time = discrepancy.time
        if variant.delay:
            assert path.period is not None
            fraction = np.mod(discrepancy.fraction - variant.delay, 1.0)
            time = path.cycle_start + (_STEADY + fraction) * path.period
        match variant.history:
            case "first revolution":
                assert path.period is not None
                later = np.where(
                    discrepancy.fraction > 1, discrepancy.fraction - 1, discrepancy.fraction
                )
                time = path.cycle_start + np.minimum(later, 1 - 1e-12) * path.period
            case "no memory" if sheared:
                return _without_memory(scene, x, time)
            case "straight steps" | "end of steps" if sheared:
                return _long_steps(discrepancy, scene, x, of_ends=variant.history == "end of steps")
        effects = None
        if variant.small_body < 0 or variant.soft_normal < 0:
            raise InputError("a body of negative height, a layer of negative compliance")
        if variant.small_body:
            effects = _of_blocks(discrepancy, scene, variant.small_body)
        if not sheared:
            layer = (
                variant.soft_normal
                * discrepancy.half_width
                / composite_modulus(discrepancy.scene.material)
            )
            return self._pressure(scene, x, time, effects, layer)[None]
        if variant.soft_normal:
            pressure = self._theory(variant, x, sheared=False)[PRESSURE]
            return np.array(
                [pressure, self._theory(replace(variant, soft_normal=0.0), x, sheared=True)[SHEAR]]
            )
        if scene.unsymmetric and one_curve(scene) is None:
            raise InputError("its memory of friction is no one curve: not looked for")
        tractions = _tractions(scene, x, time, effects=effects)
        if variant.beta:
            loads, rows = _steps(scene, time)
            tractions[SHEAR] += shear_by_coupling(scene, x, loads, rows, variant.beta)
        return tractions

    def _pressure(
        self, scene: Scene, x: Array, time: Array, effects: BodyEffects | None, layer: float
    ) -> Array:
        """(k, n) p at instants, which depends on P alone where nothing tilts the contact."""
        if effects is not None or scene.load.is_driven or self.discrepancy.comparison.turned:
            return _tractions(scene, x, time, effects=effects, fields=("pressure",))[PRESSURE]
        normal_load = np.asarray(scene.load.path().at(time)[0])
        contact = contact_of(scene.profile, scene.material)
        if layer:
            return pressure_on_layer(scene, x, normal_load, layer)
        return contact.pressure(x, normal_load[:, None])


def _shape_functions(nodes: Array) -> tuple[Array, Array]:
    """Places between nodes, (m,), and weights (m, n) of the values there in the nodal force of each
    node over its length, for linear elements.
    """
    spacings = np.diff(nodes)
    left = np.concatenate([spacings[:1], spacings])
    right = np.concatenate([spacings, spacings[-1:]])
    ends = np.concatenate([[nodes[0] - left[0]], nodes, [nodes[-1] + right[-1]]])
    share = np.arange(_BETWEEN_NODES) / _BETWEEN_NODES
    places = (ends[:-1, None] + np.diff(ends)[:, None] * share).ravel()
    distance = places[:, None] - nodes
    shape = np.maximum(1 - np.where(distance > 0, distance / right, -distance / left), 0.0)
    lengths = np.repeat(np.diff(ends) / _BETWEEN_NODES, _BETWEEN_NODES)
    return places, shape * lengths[:, None] / ((left + right) / 2)


def _tractions(
    scene: Scene,
    x: Array,
    time: Array,
    *,
    effects: BodyEffects | None = None,
    straight: bool = False,
    fields: tuple[str, ...] = ("pressure", "shear"),
) -> Tractions:
    """p and q of half-plane theory at x and at times in any order."""
    times, places = np.unique(time, return_inverse=True)
    answer = semi_analytic.solve(
        scene,
        x=x,
        time=times,
        fields=fields,
        effects=effects,
        straight_steps=straight,
    )
    return np.array([answer.pressure[places], answer.shear[places]])


def _steps(scene: Scene, time: Array) -> tuple[Array, NDArray[np.intp]]:
    """P and Q (n, 2) of steps along the path, its second revolution the last, and the (k,) rows of
    the instants.
    """
    path = scene.load.path()
    if path.period is None:
        wanted = time
        times = np.linspace(path.start, time.max(), 2 * _STEPS_A_CYCLE)
    else:
        wanted = path.cycle_start + path.period * (
            1 + np.mod((time - path.cycle_start) / path.period, 1.0)
        )
        times = np.concatenate(
            [
                np.linspace(path.start, path.cycle_start, _STEPS_A_CYCLE // 3 + 1),
                path.cycle_start + path.period * np.linspace(0, 2, 2 * _STEPS_A_CYCLE + 1),
            ]
        )
    times = np.unique(np.concatenate([times[times > path.start], wanted]))
    return np.transpose(path.at(times)), np.searchsorted(times, wanted)


def _of_blocks(discrepancy: Discrepancy, scene: Scene, share: float) -> BodyEffects:
    """Curvatures that two equal blocks of height `BLOCK_HEIGHT` a_ref add, times `share`."""
    height = BLOCK_HEIGHT * discrepancy.half_width
    unit = share * discrepancy.comparison.scales.compliance / height**2
    return BodyEffects(
        datum_length=scene.profile.datum_length,
        normal_curvature=Estimate(_NORMAL_CURVATURE * unit),
        tangential_curvature=Estimate(_TANGENTIAL_CURVATURE * unit),
    )


def _without_memory(scene: Scene, x: Array, time: Array) -> Tractions:
    """Cattaneo's first loading at every instant: q = sign(Q) f [p(x, P) - p(x, P - |Q|/f)].

    Raises
    ------
    InputError
        Where the loads slide.
    """
    f = scene.friction.coefficient
    normal, tangential = (np.asarray(load)[:, None] for load in scene.load.path().at(time))
    stuck = normal - np.abs(tangential) / f
    if not np.all(stuck > 0):
        raise InputError("the loads slide")
    contact = contact_of(scene.profile, scene.material)
    pressure = contact.pressure(x, normal)
    shear = np.sign(tangential) * f * (pressure - contact.pressure(x, stuck))
    return np.array([pressure, shear])


def _long_steps(discrepancy: Discrepancy, scene: Scene, x: Array, *, of_ends: bool) -> Tractions:
    """The result's increments in place of the path: straight lines, or (`of_ends`) as a solver
    takes them whose law holds at their ends.

    While P rises such an increment is that of P first and then that of Q at the new pressure; while
    P falls it is a straight line. Finite elements in steps that end on no event follow it to 0.983
    of the discrepancy at 48 steps a cycle, to 0.9999 at 4.
    """
    path = scene.load.path()
    assert path.period is not None
    own = discrepancy.comparison.found
    whole = discrepancy.comparison.result.time
    times = whole[whole <= own.time[-1]]
    wanted = discrepancy.time
    if whole[0] > path.cycle_start:  # the cycle alone: twice, after the initial loading
        fraction = fraction_of_cycle(discrepancy.comparison)
        cycles = [path.cycle_start + (turn + fraction) * path.period for turn in (0, 1)]
        times = np.concatenate([np.linspace(path.start, path.cycle_start, 9), *cycles])
        wanted = path.cycle_start + (1 + discrepancy.fraction) * path.period
    times = np.unique(times[times > path.start])
    places = np.abs(times[:, None] - wanted).argmin(axis=0)
    if not of_ends:
        return _tractions(scene, x, times, straight=True)[:, places]
    points = [(0.0, 0.0)]
    ends = []
    least = _SAME_LOAD * float(np.max(path.at(times)[0]))
    for normal, tangential in np.transpose(path.at(times)).tolist():
        corner = (normal, points[-1][1])
        end = (normal, tangential)
        for point in (corner, end) if normal > points[-1][0] else (end,):
            if max(abs(point[0] - points[-1][0]), abs(point[1] - points[-1][1])) > least:
                points.append(point)
        ends.append(float(len(points) - 1))  # a polygon takes one unit of time a leg
    stepped = scene.vary(load=PolygonLoad(initial_loading=tuple(points[1:])))
    return _tractions(stepped, x, np.array(ends)[places])


# ---------------------------------------------------------------------------- changes of a scene
def stiffer(scene: Scene, factor: float) -> Scene:
    """E* times `factor`."""
    upper, lower = (
        body.vary(young_modulus=factor * body.young_modulus)
        for body in (scene.material.upper, scene.material.lower)
    )
    return scene.vary(material=Materials(upper=upper, lower=lower))


def with_friction(scene: Scene, coefficient: float) -> Scene:
    """The scene with another f."""
    return scene.vary(friction=coefficient)


def wrong_loads(scene: Scene) -> dict[str, dict[str, Any]]:
    """Changes of the load: bulk stress, or tilt, of the other sign, and left out."""
    changes = {}
    for name, keys in (
        ("bulk", ("bulk_stress_lower", "bulk_stress_upper")),
        ("tilt", ("tilt", "moment", "line_of_action")),
    ):
        stated = {key: value for key in keys if (value := getattr(scene.load, key)) is not None}
        if stated:
            changes[f"{name}_sign"] = {key: _turned(value) for key, value in stated.items()}
            changes[f"{name}_left_out"] = dict.fromkeys(stated)
    return changes


def _turned(value: Any) -> Any:
    """A bulk stress, tilt or moment of the other sign, in the form that it was stated in.

    >>> _turned(0.5), _turned((0.0, 2.0)), _turned(LineOfAction(x=1.0, height=3.0))
    (-0.5, (-0.0, -2.0), LineOfAction(x=-1.0, height=-3.0))
    """
    match value:
        case Wave():
            phase = value.phase_degrees + (180 if value.phase_degrees <= 0 else -180)
            return value.vary(
                mean=-value.mean,
                phase_degrees=phase,
                initial_loading=_turned(value.initial_loading),
            )
        case WaveSum():
            waves = tuple((amplitude, phase + 180) for amplitude, phase in value.harmonics)
            return value.vary(
                mean=-value.mean, harmonics=waves, initial_loading=_turned(value.initial_loading)
            )
        case LineOfAction():
            return value.vary(x=-value.x, height=-value.height)
        case tuple():
            return tuple(-one for one in value)
        case _ if callable(value):
            return lambda time: -value(time)
    return -value
