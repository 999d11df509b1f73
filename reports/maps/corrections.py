"""Half-plane theory's figures corrected for two equal finite blocks and for a flat pad: cheap, with a stated range.

What the blocks add to the curvature under load is known (smooth walls and rollers: sums over images) or fitted (free sides, fixed
base: constants in published/maps/laws.json, from the map `block`); what that does to a cycle follows for every loop by
`reports.maps.quadratic`. Nothing here was fitted to any loop but the paper's. Of a pad W moves by k a/R, k from
`reports.maps.contour`: nothing is fitted there. The half-plane engine stays as it is.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reports.comparison.metrics import compliance
from reports.maps.contour import work_constant
from reports.maps.layers import curvature_sum
from reports.maps.quadratic import Curvatures, dissipation_error
from scenes import Block, FlatRounded, HalfPlane, Hertz, InputError, Pad, Scene
from scenes.frozen import validated
from semi_analytic.profiles import contact_of

Array = NDArray[np.float64]
LAWS = Path(__file__).parents[1] / "published" / "maps" / "laws.json"
# Where the held-out points of the map were tried: see docs/maps.md for what is left there.
LEAST_HEIGHT = 3.6  # half-widths at the largest load
LEAST_ASPECT, POISSON = 1.0, (0.25, 0.35)
MOST_CURVATURE, FLATS = 0.1, (0.2, 0.9)  # a/R and b/a of a pad
_PER_LEG = 80
_STILL = 1e-9


@dataclass(frozen=True)
class Correction:
    """What two equal blocks do to half-plane theory, each as its figure over theory's, less 1.

    Attributes
    ----------
    dissipation : of the last cycle
    peak_pressure, contact_half_width : at the largest load
    added : what the blocks add to the curvature of the gap, over 1/R, under the largest load
    height, aspect : of the blocks, over a at the largest load by half-plane theory, and width over height
    """

    dissipation: float
    peak_pressure: float
    contact_half_width: float
    added: Curvatures
    height: float
    aspect: float


def added_curvatures(base: str, aspect: float, slenderness: float, poisson_ratio: float = 0.3) -> Curvatures:
    """nu and tau of two equal blocks at a/height = `slenderness`; `base` "fixed" (sides free) or "rollers" (sides guided).

    >>> added = added_curvatures("rollers", 2.0, 0.1)
    >>> round(added.normal, 5), round(added.tangential, 5)
    (0.00543, 0.00157)
    """
    if base == "rollers":
        sums = [curvature_sum("rollers", tangential=way, poisson_ratio=poisson_ratio, aspect=aspect) for way in (False, True)]
        return Curvatures(*(-value / 2 * slenderness**2 for value in sums))
    normal, tangential = _fitted(aspect)
    return Curvatures(normal * slenderness**2, tangential * slenderness**2)


def _fitted(aspect: float) -> tuple[float, float]:
    """N and T of a block with free sides on a fixed base: fitted at some aspects, the layer's at infinity, by PCHIP between."""
    from scipy.interpolate import PchipInterpolator

    nodes = _constants()
    inverse = np.array([0.0, *sorted(1 / a for a, _, _ in nodes)])
    limits = [-curvature_sum("fixed", tangential=way) / 2 for way in (False, True)]
    found = []
    for column, limit in zip((1, 2), limits, strict=True):
        values = [limit, *(node[column] for node in sorted(nodes, key=lambda node: 1 / node[0]))]
        found.append(float(np.exp(PchipInterpolator(inverse, np.log(values))(1 / aspect))))
    return found[0], found[1]


@lru_cache(maxsize=1)
def _constants() -> tuple[tuple[float, float, float], ...]:
    """(aspect, N, T) of the published fit."""
    rows = json.loads(LAWS.read_text(encoding="utf-8"))["curvatures"]
    return tuple((row["aspect"], row["normal"], row["tangential"]) for row in rows)


def correction(scene: Scene) -> Correction:
    """What two equal blocks do to the half-plane figures of a scene.

    Raises
    ------
    InputError
        Where the correction was not derived or not tried: other than two equal blocks of one material, a profile other than Hertz,
        a path without a cycle, sides or Poisson's ratio other than in the maps, blocks too low or narrower than high.
    """
    scene = validated(scene, Scene)
    block = _block(scene)
    normal, tangential, cycle = _sampled(scene)
    largest = float(normal.max())
    half_width = _hertz(scene, largest)
    height, aspect = block.height / half_width, block.width / block.height
    _check_range(block, height, aspect, scene)
    added = added_curvatures(block.base, aspect, 1 / height, scene.material.lower.poisson_ratio)
    error = dissipation_error(normal / largest, tangential / largest, scene.friction.coefficient, added, cycle)
    if math.isnan(error):
        raise InputError(f"{scene.name or 'scene'}: load: half-plane theory dissipates nothing here, so nothing is relative to it")
    return Correction(error, added.pressure_error(), added.half_width_error(), added, height, aspect)


def corrected_dissipation(scene: Scene, value: float) -> float:
    """Half-plane theory's dissipation `value` of a scene with two equal blocks (`correction`) or a flat pad (`pad_correction`)."""
    flat_pad = isinstance(scene.profile, FlatRounded)
    return value * (1 + (pad_correction(scene) if flat_pad else correction(scene).dissipation))


def pad_correction(scene: Scene) -> float:
    """k a/R, by which the contour of a flat pad with rounded edges moves the dissipation of a cycle at constant P.

    Raises
    ------
    InputError
        Other than one pad and one half-plane of one material, a pad that its size moves too, P that moves or Q that does not go
        simply to and fro, and a/R or b/a that no finite elements were tried at.
    """
    scene = validated(scene, Scene)
    where, profile = scene.name or "scene", scene.profile
    pads = [body for body in (scene.bodies.lower, scene.bodies.upper) if isinstance(body, Pad)]
    planes = [body for body in (scene.bodies.lower, scene.bodies.upper) if isinstance(body, HalfPlane)]
    if not isinstance(profile, FlatRounded) or len(pads) != 1 or len(planes) != 1:
        raise InputError(f"{where}: bodies: the correction is for a pad with a flat face on a half-plane; take `halfplane run`")
    if scene.material.lower != scene.material.upper:
        raise InputError(f"{where}: material: the correction is for a pad and a half-plane of one material; take `halfplane run`")
    if too_small := smaller_than_the_maps(profile, pads[0]):
        raise InputError(f"{where}: bodies: the pad is too small: {too_small}")
    cycle = to_and_fro(scene)
    half_width = float(contact_of(profile, scene.material).half_width(cycle.load))
    curvature, flat = half_width / profile.radius, profile.flat_half_length / half_width
    if curvature > MOST_CURVATURE * (1 + 1e-9) or not FLATS[0] * (1 - 1e-9) <= flat <= FLATS[1] * (1 + 1e-9):
        raise InputError(
            f"{where}: profile: a/R = {curvature:.3g} with b/a = {flat:.3g} is refused: the correction holds up to "
            f"{MOST_CURVATURE:g} and for b/a of {FLATS[0]:g} to {FLATS[1]:g}"
        )
    return work_constant(flat, cycle.ratio) * curvature


def smaller_than_the_maps(profile: FlatRounded, pad: Pad) -> str:
    """Which pads the map `curvature` has, where this one is smaller than they are; else empty."""
    width = 2 * profile.flat_half_length + 1.4 * profile.radius
    if pad.height >= 0.99 * profile.radius and pad.width >= 0.99 * width:
        return ""
    return f"the map `curvature` has pads 2 b + 1.4 R = {width:g} wide and R = {profile.radius:g} high, or larger"


@dataclass(frozen=True)
class ToAndFro:
    """A cycle at constant P in which Q turns twice: P, half of the range of Q over f P, the largest |Q| over P."""

    load: float
    ratio: float
    largest: float


def to_and_fro(scene: Scene) -> ToAndFro:
    """The cycle of a scene, where it is of that kind.

    Raises
    ------
    InputError
        For any other.
    """
    where = scene.name or "scene"
    *loads, cycle = _sampled(scene)
    normal, tangential = (load[-cycle - 1 :] for load in loads)
    moves = np.sign(np.diff(tangential)[np.abs(np.diff(tangential)) > _STILL * np.abs(tangential).max()])
    turns = int(np.sum(moves != np.roll(moves, 1)))
    if np.ptp(normal) > _STILL * normal.max() or turns != 2:
        raise InputError(
            f"{where}: load: a pad's correction is for constant P and a Q that turns twice in a cycle; take `halfplane run`"
        )
    load = float(normal[0])
    ratio = float(np.ptp(tangential)) / (2 * scene.friction.coefficient * load)
    if ratio >= 1:
        raise InputError(f"{where}: load: half of Q's range is {ratio:.3g} f P: the contact slides, which no correction is for")
    return ToAndFro(load, ratio, float(np.abs(tangential).max()) / load)


def _sampled(scene: Scene) -> tuple[Array, Array, int]:
    """P and Q over the initial loading and two cycles, (n,) each, and how many of these instants are of the second cycle."""
    path = scene.load.path()
    if path.period is None:
        raise InputError(f"{scene.name or 'scene'}: load: the path has no cycle, and the correction is that of a cycle")
    times = _times(path.start, path.cycle_start, path.period)
    normal, tangential = np.array([[float(part) for part in path.at(t)] for t in times]).T
    return normal, tangential, int(np.sum(times > path.cycle_start + path.period * (1 + 1e-9)))


def _times(start: float, cycle_start: float, period: float) -> Array:
    """Initial loading and two cycles; the corners of polygons are among them, for legs last one unit."""
    legs = max(1, round(period)) if abs(period - round(period)) < 1e-9 else 4
    way = np.linspace(start, cycle_start, _PER_LEG * max(1, round(cycle_start - start)) + 1)[1:]
    return np.concatenate([way, cycle_start + np.linspace(0, 2 * period, 2 * legs * _PER_LEG + 1)[1:]])


def _hertz(scene: Scene, load: float) -> float:
    # notation: a^2 = 4 P R/(pi E*) = 2 A P R/pi
    assert isinstance(scene.profile, Hertz)
    return math.sqrt(2 * load * scene.profile.radius * compliance(scene.material) / math.pi)


def _block(scene: Scene) -> Block:
    """The one shape of both bodies."""
    lower, upper, where = scene.bodies.lower, scene.bodies.upper, scene.name or "scene"
    if not isinstance(lower, Block) or lower != upper:
        raise InputError(f"{where}: bodies: the correction is for two equal blocks; take `halfplane run` for these")
    if scene.material.lower != scene.material.upper:
        raise InputError(f"{where}: material: the correction is for two blocks of one material; take `halfplane run`")
    if not isinstance(scene.profile, Hertz):
        raise InputError(f"{where}: profile.kind = {scene.profile.kind!r}: the correction is for 'hertz'; take `halfplane run`")
    if (lower.base, lower.sides) not in (("fixed", "free"), ("rollers", "guided")):
        raise InputError(
            f"{where}: bodies: base = {lower.base!r} with sides = {lower.sides!r} is in no map; "
            "the correction is for fixed and free, or rollers and guided"
        )
    return lower


def _check_range(block: Block, height: float, aspect: float, scene: Scene) -> None:
    where, ratio = scene.name or "scene", scene.material.lower.poisson_ratio
    if height < LEAST_HEIGHT:
        raise InputError(
            f"{where}: bodies: height = {height:.3g} half-widths is refused: the correction holds from {LEAST_HEIGHT:g} on"
        )
    if aspect < LEAST_ASPECT:
        raise InputError(f"{where}: bodies: width/height = {aspect:.3g} is refused: the correction holds from {LEAST_ASPECT:g} on")
    if block.base == "fixed" and not POISSON[0] <= ratio <= POISSON[1]:
        raise InputError(
            f"{where}: material.poisson_ratio = {ratio:g} is refused: the correction was fitted at 0.3 and holds in {POISSON}"
        )
