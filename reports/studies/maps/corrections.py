"""Half-plane theory's values corrected for finite bodies and faces that are no parabola.
Derivations: docs/maps.md.

First what such a body adds to half-plane theory and what that does to a cycle, then the
corrections, cheap and with a stated range. Of two equal blocks the added curvature is known (smooth
walls, rollers) or fitted (free sides, fixed base: published/maps/laws.json). Of a flat pad W moves
by k a/R; nothing is fitted.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator
from scipy.special import xlogy

import semi_analytic
from reports.studies.maps.laws import PUBLISHED
from scenes import Block, Elastic, FlatRounded, HalfPlane, Hertz, InputError, Materials, Pad, Scene
from scenes.array_types import Array
from scenes.frozen import validated
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import contact_of

Base = Literal["fixed", "rollers"]
_FAR = 40.0  # L - 1 of a layer decays like w^2 exp(-2 w)
# of the memory curve and of an ellipse: W of half-planes is then met to 2e-4
_CELLS = 600
_STEPS = 400
_NOTHING = 1e-9  # full stick leaves round-off of the order of 1e-16
_NODES = 24  # a part of the rule for contours: 1e-6 up to b/a = 0.99
# Where the held-out points of the maps were tried: see docs/maps.md for what is left there.
# height in half-widths at the largest load
_LEAST_HEIGHT = 3.6
_LEAST_ASPECT = 1.0
_POISSON = (0.25, 0.35)
# a/R and b/a of a pad
_MOST_CURVATURE = 0.1
_FLATS = (0.2, 0.9)
_PER_LEG = 80
_STILL = 1e-9


# ------------------------------------------------------------------------------------------- layers
def _response(base: Base, tangential: bool, poisson_ratio: float) -> Callable[[Array], Array]:
    """L(w) of a layer that is fixed to its base or slides on it, for normal or tangential forces
    (Johnson 1985, section 5.8).
    """
    kappa = 3 - 4 * poisson_ratio
    sense = 1.0 if tangential else -1.0

    def fixed(w: Array) -> Array:
        low = 2 * kappa * np.sinh(2 * w) + sense * 4 * w
        return np.asarray(low / (2 * kappa * np.cosh(2 * w) + 1 + kappa**2 + 4 * w**2))

    def sliding(w: Array) -> Array:
        return np.asarray((np.cosh(2 * w) + sense) / (2 * w + np.sinh(2 * w)))

    return fixed if base == "fixed" else sliding


def curvature_sum(
    base: Base, *, tangential: bool = False, poisson_ratio: float = 0.3, aspect: float = np.inf
) -> float:
    """S = int (L(w) - 1) w dw of a layer, or its sum for a block between smooth walls whose width
    is `aspect` times its height.

    >>> round(-curvature_sum("fixed") / 4, 4)
    0.358
    """
    layer = _response(base, tangential, poisson_ratio)
    if np.isinf(aspect):
        return float(quad(lambda w: (layer(np.array(w)) - 1) * w, 1e-12, _FAR, limit=200)[0])
    # Walls are a row of images; zeta(-1) is what the same sum does to L = 1.
    step = 2 * np.pi / aspect
    w: Array = step * (np.arange(1.0, int(_FAR / step) + 2) - (0.5 if tangential else 0.0))
    return float(np.sum((layer(w) - 1) * w * step)) + (
        step**2 / 24 if tangential else -(step**2) / 12
    )


# ----------------------------------------------------------- half-planes with a quadratic part more
@dataclass(frozen=True)
class Curvatures:
    """nu and tau: what finite bodies add to the relative curvature under P0, normal and tangential,
    as shares of 1/R.
    """

    normal: float
    tangential: float

    def pressure_error(self) -> float:
        """Peak pressure over that of half-planes, minus 1, at P0.

        >>> round(Curvatures(0.02, 0.0).pressure_error(), 6)
        0.00995
        """
        return float(np.sqrt(1 + self.normal)) - 1


def dissipation(
    normal_load: Array, tangential_load: Array, friction: float, added: Curvatures, last: int
) -> float:
    """Friction work of the last `last` steps, a closed cycle, over A P0^2/pi.

    Parameters
    ----------
    normal_load, tangential_load
        path from rest (n,), over P0; straight between its points
    friction
        coefficient
    added
        what the bodies add; (0, 0) for half-planes
    last
        steps of the closed cycle at the end

    Notes
    -----
    The closed integral of Q dU. U is over A P0/pi, its constant part left out: it does no work in a
    cycle.
    """
    # notation: g = alpha^2 of the cells' borders, M = force of the punches up to alpha, frozen = M
    # less that of the curvature tau Q
    nu = added.normal
    tau = added.tangential
    square = normal_load / (1 + nu * normal_load)
    g = np.linspace(0.0, float(np.max(square)), _CELLS + 1)
    # Mean of log(1/alpha) + tau alpha^2/2 over each cell.
    mean = np.diff((g - xlogy(g, g)) / 2) / np.diff(g) + tau * (g[1:] + g[:-1]) / 4
    # of M at the borders instead of m in the cells
    weights = -np.diff(mean, prepend=0.0, append=0.0)
    frozen = np.zeros_like(g)
    before = 0.0
    shifts = np.empty(len(normal_load))
    for number, (p, q, here) in enumerate(zip(normal_load, tangential_load, square, strict=True)):
        edge = int(np.searchsorted(g, here))
        carried = np.full_like(g, q)
        carried[:edge] = frozen[:edge] + tau * q * np.minimum(g[:edge], before)
        if here > before:
            first = int(np.searchsorted(g, before, side="right"))
            start = float(np.interp(before, g, frozen)) + tau * q * before
            carried[first:edge] = start + (q - start) * (g[first:edge] - before) / (here - before)
        # What friction can carry outside alpha.
        bound = friction * (1 + nu * p) * (here - g[:edge])
        np.clip(carried[:edge], q - bound, q + bound, out=carried[:edge])
        shifts[number] = carried @ weights
        frozen = carried - tau * q * np.minimum(g, here)
        before = float(here)
    shift = shifts[-last - 1 :]
    q = tangential_load[-last - 1 :]
    return float(np.sum((q[1:] + q[:-1]) / 2 * np.diff(shift)))


def dissipation_error(
    normal_load: Array, tangential_load: Array, friction: float, added: Curvatures, last: int
) -> float:
    """Friction work over that of half-planes on the same path and steps, less 1; NaN where these
    dissipate nothing.
    """
    path = (normal_load, tangential_load, friction)
    plain = dissipation(*path, Curvatures(0.0, 0.0), last)
    return (
        dissipation(*path, added, last) / plain - 1
        if plain > _NOTHING * friction**2
        else float("nan")
    )


def ellipse_path(
    normal_amplitude: float, mean: float, amplitude: float, phase: float
) -> tuple[Array, Array, int]:
    """P/P0 (n,) and Q/P0 (n,) of two turns of an ellipse from rest, straight to where Q is least,
    and the steps of a turn.

    Loads are over P0, the phase in rad.
    """
    t = phase + np.pi + np.linspace(0.0, 4 * np.pi, 2 * _STEPS + 1)
    p = 1 + normal_amplitude * np.cos(t)
    q = mean + amplitude * np.cos(t - phase)
    way = np.linspace(0.0, 1.0, 100)[1:-1]
    return np.concatenate([way * p[0], p]), np.concatenate([way * q[0], q]), _STEPS


# -------------------------------------------------------------------- contours that are no parabola
def _potential(x: Array, flat: float) -> Array:
    """Phi (n,) at x (n,) of a flat of half-length `flat` with edges of radius 1, its linear part
    left out.

    >>> _potential(np.array([0.0, 1.0]), 1.0).round(6).tolist()
    [0.0, 1.386294]
    """
    return (xlogy((x + flat) ** 2, np.abs(x + flat)) - xlogy((x - flat) ** 2, np.abs(x - flat))) / 2


def _kernel(x: Array, xi: Array, flat: float) -> Array:
    """K (n, m) between points x (n,) and xi (m,): the slope of Phi where they coincide."""
    apart = x[:, None] - xi[None, :]
    slope = xlogy(x + flat, np.abs(x + flat)) - xlogy(x - flat, np.abs(x - flat)) + flat
    quotient = (_potential(x, flat)[:, None] - _potential(xi, flat)[None, :]) / np.where(
        apart == 0, 1.0, apart
    )
    return np.where(apart == 0, slope[:, None], quotient)


def work_constant(flat: float, ratio: float, nodes: int = _NODES) -> float:
    """k of W = (1 + k a/R) times that of half-planes, for one body whose face is flat with rounded
    edges, and one half-plane alike.

    P is constant and Q goes to and fro; both bodies have one E'.

    Parameters
    ----------
    flat
        b/a, at least 0 (a cylinder) and less than 1
    ratio
        half of the range of Q over f P, above 0 and less than 1
    nodes
        of the rule in each part

    Examples
    --------
    >>> round(work_constant(0.5, 0.6), 4)
    -0.4603
    """
    # notation: a = R = E* = f = 1, so that E' = 2; stuck P - Q/f, load P; dG = int int dk q q/2,
    # dG' = int int dk q m
    alike = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    profile = FlatRounded(radius=1.0, flat_half_length=flat) if flat > 0 else Hertz(radius=1.0)
    materials = Materials(upper=alike, lower=alike)
    contact = contact_of(profile, materials)
    load = float(contact.load(1.0))
    stuck = (1 - ratio) * load
    shear = ratio * load
    edge = float(contact.half_width(stuck))
    angle, weight = _angles((flat, edge, 1.0), nodes)
    x = np.sin(angle)
    force = (contact.pressure(x, load) - contact.pressure(x, stuck)) * np.cos(angle) * weight
    within, share = _angles((flat / edge, 1.0), nodes)
    punch = share / np.pi @ _kernel(edge * np.sin(within), x, flat) @ force
    change = 4 * (2 / np.pi**2) * (shear * punch - force @ _kernel(x, x, flat) @ force)
    cycle: dict[str, Any] = {
        "mean_normal_load": load,
        "normal_amplitude": 0.0,
        "mean_tangential_load": 0.0,
        "tangential_amplitude": shear,
    }
    plain = semi_analytic.dissipation(
        profile=profile, material=materials, friction_coefficient=1.0, phase_degrees=0.0, **cycle
    )
    return float(change) / float(plain.value)


def _angles(ends: tuple[float, ...], nodes: int) -> tuple[Array, Array]:
    """Angles and weights (n,) of a rule over sin(angle) from -1 to 1, cut at +-`ends` and dense
    there (roots, logarithms).
    """
    cuts = np.unique(np.arcsin([0.0, *ends]))
    s, weight = np.polynomial.legendre.leggauss(nodes)
    s = (s + 1) / 2
    weight = weight / 2
    begin = cuts[:-1, None]
    length = np.diff(cuts)[:, None]
    angle = (begin + length * s**2 * (3 - 2 * s)).ravel()
    share = (length * 6 * s * (1 - s) * weight).ravel()
    return np.concatenate([-angle[::-1], angle]), np.concatenate([share[::-1], share])


def share_of(body: Elastic, materials: Materials) -> float:
    """2 E*/E' of the body that is curved, by which its law counts: 1 for like materials, 2 on a
    rigid half-plane.

    >>> steel = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    >>> round(share_of(steel, Materials(upper=steel, lower=steel)), 12)
    1.0
    """
    return 2 * composite_modulus(materials) * (1 - body.poisson_ratio**2) / body.young_modulus


# -------------------------------------------------------------------------------------- corrections
@dataclass(frozen=True)
class Correction:
    """What two equal blocks do to half-plane theory, each as its value over theory's, less 1."""

    dissipation: float  # of the last cycle
    peak_pressure: float  # at the largest load, as the half-width
    contact_half_width: float
    added: Curvatures  # to the curvature of the gap, over 1/R, under the largest load
    height: float  # over a at the largest load by half-plane theory
    aspect: float  # width over height


def added_curvatures(
    base: str, aspect: float, slenderness: float, poisson_ratio: float = 0.3
) -> Curvatures:
    """nu and tau of two equal blocks at a/height = `slenderness`; `base` "fixed" (sides free) or
    "rollers" (sides guided).

    >>> added = added_curvatures("rollers", 2.0, 0.1)
    >>> round(added.normal, 5), round(added.tangential, 5)
    (0.00543, 0.00157)
    """
    if base == "rollers":
        sums = [
            curvature_sum("rollers", tangential=way, poisson_ratio=poisson_ratio, aspect=aspect)
            for way in (False, True)
        ]
        return Curvatures(*(-value / 2 * slenderness**2 for value in sums))
    return Curvatures(*(float(np.exp(log(1 / aspect))) * slenderness**2 for log in _fitted()))


@lru_cache(maxsize=1)
def _fitted() -> tuple[PchipInterpolator, PchipInterpolator]:
    """ln N and ln T over height/width, free sides on a fixed base: fitted at some, the layer's at
    0.
    """
    rows = sorted(
        json.loads((PUBLISHED / "laws.json").read_text(encoding="utf-8"))["curvatures"],
        key=lambda row: -row["aspect"],
    )
    at = [0.0, *(1 / row["aspect"] for row in rows)]
    normal, tangential = (
        PchipInterpolator(
            at,
            np.log(
                [
                    -curvature_sum("fixed", tangential=name == "tangential") / 2,
                    *(row[name] for row in rows),
                ]
            ),
        )
        for name in ("normal", "tangential")
    )
    return normal, tangential


def correction(scene: Scene) -> Correction:
    """What two equal blocks do to the half-plane values of a scene.

    Raises
    ------
    InputError
        Where the correction was not derived or not tried: other than two equal blocks of one
        material, a profile other than Hertz, a path without a cycle, sides or Poisson's ratio other
        than in the maps, blocks too low or narrower than high.
    """
    scene = validated(scene, Scene)
    block = scene.bodies.lower
    ratio = scene.material.lower.poisson_ratio
    if not isinstance(block, Block) or block != scene.bodies.upper:
        raise _refusal(
            scene, "bodies: the correction is for two equal blocks; take `halfplane run` for these"
        )
    if scene.material.lower != scene.material.upper:
        raise _refusal(
            scene,
            "material: the correction is for two blocks of one material; take `halfplane run`",
        )
    if not isinstance(scene.profile, Hertz):
        raise _refusal(
            scene,
            f"profile.kind = {scene.profile.kind!r}: the correction is for 'hertz'; take `halfplane"
            " run`",
        )
    if (block.base, block.sides) not in (("fixed", "free"), ("rollers", "guided")):
        kind = f"base = {block.base!r} with sides = {block.sides!r}"
        raise _refusal(
            scene,
            f"bodies: {kind} is in no map; the correction is for fixed and free, or rollers and"
            " guided",
        )
    normal, tangential, cycle = _sampled(scene)
    largest = float(normal.max())
    height = block.height / float(contact_of(scene.profile, scene.material).half_width(largest))
    aspect = block.width / block.height
    if height < _LEAST_HEIGHT:
        raise _refusal(
            scene,
            f"bodies: height = {height:.3g} half-widths is refused: the correction holds from"
            f" {_LEAST_HEIGHT:g} on",
        )
    if aspect < _LEAST_ASPECT:
        raise _refusal(
            scene,
            f"bodies: width/height = {aspect:.3g} is refused: the correction holds from"
            f" {_LEAST_ASPECT:g} on",
        )
    if block.base == "fixed" and not _POISSON[0] <= ratio <= _POISSON[1]:
        words = (
            f"material.poisson_ratio = {ratio:g} is refused: the correction was fitted at 0.3 and"
            f" holds in {_POISSON}"
        )
        raise _refusal(scene, words)
    added = added_curvatures(block.base, aspect, 1 / height, ratio)
    error = dissipation_error(
        normal / largest, tangential / largest, scene.friction.coefficient, added, cycle
    )
    if math.isnan(error):
        raise _refusal(
            scene, "load: half-plane theory dissipates nothing here, so nothing is relative to it"
        )
    return Correction(
        error, added.pressure_error(), 1 / (1 + added.pressure_error()) - 1, added, height, aspect
    )


def corrected_dissipation(scene: Scene, value: float) -> float:
    """Half-plane theory's dissipation `value` of a scene with two equal blocks (`correction`) or a
    flat pad (`pad_correction`).
    """
    flat_pad = isinstance(scene.profile, FlatRounded)
    return value * (1 + (pad_correction(scene) if flat_pad else correction(scene).dissipation))


def pad_correction(scene: Scene) -> float:
    """k a/R, by which the contour of a flat pad with rounded edges moves the dissipation of a cycle
    at constant P.

    Raises
    ------
    InputError
        Other than one pad and one half-plane of one material, a pad that its size moves too, P that
        moves or Q that does not go simply to and fro, and a/R or b/a that no finite elements were
        tried at.
    """
    scene = validated(scene, Scene)
    profile = scene.profile
    bodies = (scene.bodies.lower, scene.bodies.upper)
    pads = [body for body in bodies if isinstance(body, Pad)]
    if (
        not isinstance(profile, FlatRounded)
        or len(pads) != 1
        or not any(isinstance(body, HalfPlane) for body in bodies)
    ):
        raise _refusal(
            scene,
            "bodies: the correction is for a pad with a flat face on a half-plane; take `halfplane"
            " run`",
        )
    if scene.material.lower != scene.material.upper:
        raise _refusal(
            scene,
            "material: the correction is for a pad and a half-plane of one material; take"
            " `halfplane run`",
        )
    if too_small := smaller_than_the_maps(profile, pads[0]):
        raise _refusal(scene, f"bodies: the pad is too small: {too_small}")
    cycle = to_and_fro(scene)
    half_width = float(contact_of(profile, scene.material).half_width(cycle.load))
    curvature = half_width / profile.radius
    flat = profile.flat_half_length / half_width
    if curvature > _MOST_CURVATURE * (1 + 1e-9) or not _FLATS[0] * (1 - 1e-9) <= flat <= _FLATS[
        1
    ] * (1 + 1e-9):
        held = (
            f"the correction holds up to {_MOST_CURVATURE:g} and for b/a of {_FLATS[0]:g} to"
            f" {_FLATS[1]:g}"
        )
        raise _refusal(
            scene, f"profile: a/R = {curvature:.3g} with b/a = {flat:.3g} is refused: {held}"
        )
    return work_constant(flat, cycle.ratio) * curvature


def smaller_than_the_maps(profile: FlatRounded, pad: Pad) -> str:
    """Which pads the map `curvature` has, where this one is smaller than they are; else empty."""
    width = 2 * profile.flat_half_length + 1.4 * profile.radius
    if pad.height >= 0.99 * profile.radius and pad.width >= 0.99 * width:
        return ""
    return (
        f"the map `curvature` has pads 2 b + 1.4 R = {width:g} wide and R = {profile.radius:g}"
        " high, or larger"
    )


class ToAndFro(NamedTuple):
    """A cycle at constant P in which Q turns twice."""

    load: float  # P
    ratio: float  # half of the range of Q over f P
    largest: float  # |Q| over P


def to_and_fro(scene: Scene) -> ToAndFro:
    """The cycle of a scene; InputError where it is not of that kind."""
    *loads, cycle = _sampled(scene)
    normal, tangential = (load[-cycle - 1 :] for load in loads)
    moves = np.sign(
        np.diff(tangential)[np.abs(np.diff(tangential)) > _STILL * np.abs(tangential).max()]
    )
    if np.ptp(normal) > _STILL * normal.max() or np.sum(moves != np.roll(moves, 1)) != 2:
        words = (
            "a pad's correction is for constant P and a Q that turns twice in a cycle; take"
            " `halfplane run`"
        )
        raise _refusal(scene, f"load: {words}")
    load = float(normal[0])
    ratio = float(np.ptp(tangential)) / (2 * scene.friction.coefficient * load)
    if ratio >= 1:
        raise _refusal(
            scene,
            f"load: half of Q's range is {ratio:.3g} f P: the contact slides, which no correction"
            " is for",
        )
    return ToAndFro(load, ratio, float(np.abs(tangential).max()) / load)


def _sampled(scene: Scene) -> tuple[Array, Array, int]:
    """P and Q over the initial loading and two cycles, (n,) each, and how many of these instants
    are of the second cycle.
    """
    path = scene.load.path()
    if path.period is None:
        raise _refusal(scene, "load: the path has no cycle, and the correction is that of a cycle")
    # The corners of polygons are among the instants, for their legs last one unit.
    whole = abs(path.period - round(path.period)) < 1e-9
    legs = max(1, round(path.period)) if whole else 4
    way = np.linspace(
        path.start, path.cycle_start, _PER_LEG * max(1, round(path.cycle_start - path.start)) + 1
    )[1:]
    cycles = path.cycle_start + np.linspace(0, 2 * path.period, 2 * legs * _PER_LEG + 1)[1:]
    normal, tangential = (
        np.asarray(part, dtype=float) for part in path.at(np.concatenate([way, cycles]))
    )
    return normal, tangential, int(np.sum(cycles > path.cycle_start + path.period * (1 + 1e-9)))


def _refusal(scene: Scene, words: str) -> InputError:
    return InputError(f"{scene.name or 'scene'}: {words}")
