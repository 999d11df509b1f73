"""Half-plane theory's values corrected for two equal finite blocks and for a flat pad: cheap, with a stated range.

Of blocks the added curvature is known (smooth walls, rollers) or fitted (free sides, fixed base: published/maps/laws.json). Of a
pad W moves by k a/R; nothing is fitted. What that does to a cycle follows from `theory`.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from reports.maps.atlas import PUBLISHED
from reports.maps.theory import Curvatures, curvature_sum, dissipation_error, work_constant
from scenes import Block, FlatRounded, HalfPlane, Hertz, InputError, Pad, Scene
from scenes.frozen import validated
from semi_analytic.profiles import contact_of

Array = NDArray[np.float64]
# Where the held-out points of the maps were tried: see docs/maps.md for what is left there.
LEAST_HEIGHT, LEAST_ASPECT, POISSON = 3.6, 1.0, (0.25, 0.35)  # height in half-widths at the largest load
MOST_CURVATURE, FLATS = 0.1, (0.2, 0.9)  # a/R and b/a of a pad
_PER_LEG = 80
_STILL = 1e-9


@dataclass(frozen=True)
class Correction:
    """What two equal blocks do to half-plane theory, each as its value over theory's, less 1."""

    dissipation: float  # of the last cycle
    peak_pressure: float  # at the largest load, as the half-width
    contact_half_width: float
    added: Curvatures  # to the curvature of the gap, over 1/R, under the largest load
    height: float  # over a at the largest load by half-plane theory
    aspect: float  # width over height


def added_curvatures(base: str, aspect: float, slenderness: float, poisson_ratio: float = 0.3) -> Curvatures:
    """nu and tau of two equal blocks at a/height = `slenderness`; `base` "fixed" (sides free) or "rollers" (sides guided).

    >>> added = added_curvatures("rollers", 2.0, 0.1)
    >>> round(added.normal, 5), round(added.tangential, 5)
    (0.00543, 0.00157)
    """
    if base == "rollers":
        sums = [curvature_sum("rollers", tangential=way, poisson_ratio=poisson_ratio, aspect=aspect) for way in (False, True)]
        return Curvatures(*(-value / 2 * slenderness**2 for value in sums))
    return Curvatures(*(float(np.exp(log(1 / aspect))) * slenderness**2 for log in _fitted()))


@lru_cache(maxsize=1)
def _fitted() -> tuple[PchipInterpolator, PchipInterpolator]:
    """ln N and ln T over height/width, free sides on a fixed base: fitted at some, the layer's at 0."""
    rows = sorted(json.loads((PUBLISHED / "laws.json").read_text(encoding="utf-8"))["curvatures"], key=lambda row: -row["aspect"])
    at = [0.0, *(1 / row["aspect"] for row in rows)]
    normal, tangential = (
        PchipInterpolator(at, np.log([-curvature_sum("fixed", tangential=name == "tangential") / 2, *(row[name] for row in rows)]))
        for name in ("normal", "tangential")
    )
    return normal, tangential


def correction(scene: Scene) -> Correction:
    """What two equal blocks do to the half-plane values of a scene.

    Raises
    ------
    InputError
        Where the correction was not derived or not tried: other than two equal blocks of one material, a profile other than Hertz,
        a path without a cycle, sides or Poisson's ratio other than in the maps, blocks too low or narrower than high.
    """
    scene = validated(scene, Scene)
    block, ratio = scene.bodies.lower, scene.material.lower.poisson_ratio
    if not isinstance(block, Block) or block != scene.bodies.upper:
        raise _refusal(scene, "bodies: the correction is for two equal blocks; take `halfplane run` for these")
    if scene.material.lower != scene.material.upper:
        raise _refusal(scene, "material: the correction is for two blocks of one material; take `halfplane run`")
    if not isinstance(scene.profile, Hertz):
        raise _refusal(scene, f"profile.kind = {scene.profile.kind!r}: the correction is for 'hertz'; take `halfplane run`")
    if (block.base, block.sides) not in (("fixed", "free"), ("rollers", "guided")):
        kind = f"base = {block.base!r} with sides = {block.sides!r}"
        raise _refusal(scene, f"bodies: {kind} is in no map; the correction is for fixed and free, or rollers and guided")
    normal, tangential, cycle = _sampled(scene)
    largest = float(normal.max())
    height = block.height / float(contact_of(scene.profile, scene.material).half_width(largest))
    aspect = block.width / block.height
    if height < LEAST_HEIGHT:
        raise _refusal(
            scene, f"bodies: height = {height:.3g} half-widths is refused: the correction holds from {LEAST_HEIGHT:g} on"
        )
    if aspect < LEAST_ASPECT:
        raise _refusal(scene, f"bodies: width/height = {aspect:.3g} is refused: the correction holds from {LEAST_ASPECT:g} on")
    if block.base == "fixed" and not POISSON[0] <= ratio <= POISSON[1]:
        words = f"material.poisson_ratio = {ratio:g} is refused: the correction was fitted at 0.3 and holds in {POISSON}"
        raise _refusal(scene, words)
    added = added_curvatures(block.base, aspect, 1 / height, ratio)
    error = dissipation_error(normal / largest, tangential / largest, scene.friction.coefficient, added, cycle)
    if math.isnan(error):
        raise _refusal(scene, "load: half-plane theory dissipates nothing here, so nothing is relative to it")
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
    profile, bodies = scene.profile, (scene.bodies.lower, scene.bodies.upper)
    pads = [body for body in bodies if isinstance(body, Pad)]
    if not isinstance(profile, FlatRounded) or len(pads) != 1 or not any(isinstance(body, HalfPlane) for body in bodies):
        raise _refusal(scene, "bodies: the correction is for a pad with a flat face on a half-plane; take `halfplane run`")
    if scene.material.lower != scene.material.upper:
        raise _refusal(scene, "material: the correction is for a pad and a half-plane of one material; take `halfplane run`")
    if too_small := smaller_than_the_maps(profile, pads[0]):
        raise _refusal(scene, f"bodies: the pad is too small: {too_small}")
    cycle = to_and_fro(scene)
    half_width = float(contact_of(profile, scene.material).half_width(cycle.load))
    curvature, flat = half_width / profile.radius, profile.flat_half_length / half_width
    if curvature > MOST_CURVATURE * (1 + 1e-9) or not FLATS[0] * (1 - 1e-9) <= flat <= FLATS[1] * (1 + 1e-9):
        held = f"the correction holds up to {MOST_CURVATURE:g} and for b/a of {FLATS[0]:g} to {FLATS[1]:g}"
        raise _refusal(scene, f"profile: a/R = {curvature:.3g} with b/a = {flat:.3g} is refused: {held}")
    return work_constant(flat, cycle.ratio) * curvature


def smaller_than_the_maps(profile: FlatRounded, pad: Pad) -> str:
    """Which pads the map `curvature` has, where this one is smaller than they are; else empty."""
    width = 2 * profile.flat_half_length + 1.4 * profile.radius
    if pad.height >= 0.99 * profile.radius and pad.width >= 0.99 * width:
        return ""
    return f"the map `curvature` has pads 2 b + 1.4 R = {width:g} wide and R = {profile.radius:g} high, or larger"


class ToAndFro(NamedTuple):
    """A cycle at constant P in which Q turns twice."""

    load: float  # P
    ratio: float  # half of the range of Q over f P
    largest: float  # |Q| over P


def to_and_fro(scene: Scene) -> ToAndFro:
    """The cycle of a scene; InputError where it is not of that kind."""
    *loads, cycle = _sampled(scene)
    normal, tangential = (load[-cycle - 1 :] for load in loads)
    moves = np.sign(np.diff(tangential)[np.abs(np.diff(tangential)) > _STILL * np.abs(tangential).max()])
    if np.ptp(normal) > _STILL * normal.max() or np.sum(moves != np.roll(moves, 1)) != 2:
        words = "a pad's correction is for constant P and a Q that turns twice in a cycle; take `halfplane run`"
        raise _refusal(scene, f"load: {words}")
    load = float(normal[0])
    ratio = float(np.ptp(tangential)) / (2 * scene.friction.coefficient * load)
    if ratio >= 1:
        raise _refusal(scene, f"load: half of Q's range is {ratio:.3g} f P: the contact slides, which no correction is for")
    return ToAndFro(load, ratio, float(np.abs(tangential).max()) / load)


def _sampled(scene: Scene) -> tuple[Array, Array, int]:
    """P and Q over the initial loading and two cycles, (n,) each, and how many of these instants are of the second cycle."""
    path = scene.load.path()
    if path.period is None:
        raise _refusal(scene, "load: the path has no cycle, and the correction is that of a cycle")
    # The corners of polygons are among the instants, for their legs last one unit.
    whole = abs(path.period - round(path.period)) < 1e-9
    legs = max(1, round(path.period)) if whole else 4
    way = np.linspace(path.start, path.cycle_start, _PER_LEG * max(1, round(path.cycle_start - path.start)) + 1)[1:]
    cycles = path.cycle_start + np.linspace(0, 2 * path.period, 2 * legs * _PER_LEG + 1)[1:]
    normal, tangential = (np.asarray(part, dtype=float) for part in path.at(np.concatenate([way, cycles])))
    return normal, tangential, int(np.sum(cycles > path.cycle_start + path.period * (1 + 1e-9)))


def _refusal(scene: Scene, words: str) -> InputError:
    return InputError(f"{scene.name or 'scene'}: {words}")
