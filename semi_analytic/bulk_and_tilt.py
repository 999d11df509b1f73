"""From a scene with bulk stress and tilt to the family of its contact intervals: which load paths
have one memory curve.

# notation: alpha tilt, eps = sigma_lower/E'_lower - sigma_upper/E'_upper with E' = E/(1 - nu^2),
kappa as in `tilted_profile`
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import (
    NORMAL_LOAD,
    Combination,
    HarmonicSegment,
    Hertz,
    InputError,
    LoadPath,
    LoadSegment,
    Materials,
    Scene,
    StraightSegment,
)
from scenes.chebyshev import Unresolved
from semi_analytic.elasticity import composite_modulus
from semi_analytic.opposite_slip import OppositeSlip
from semi_analytic.profiles import contact_of, convex_profile
from semi_analytic.tilted_profile import ConvexProfile, NestedIntervals, TiltedProfile

Array = NDArray[np.float64]

# Share of the largest value, or of what would make a whole edge slip, within which two affine
# functions are one.
_ROUNDING = 1e-11
# Instants of a curved leg that are compared, besides two for each turn that it may take.
_SAMPLES = 40

NO_ONE_CURVE = (
    "load: events are turns of the one memory curve, and these loads have none: that takes bulk"
    " strain that is kappa Q and tilt that is kappa P, with the same kappa and each with a"
    " constant, and contact intervals that stay nested; `solve` answers them"
)
"""Why events are refused of a scene that `one_curve` does not take."""


@dataclass(frozen=True, eq=False)
class OneCurve:
    """A load path with bulk stress and tilt whose memory is one curve.

    Attributes
    ----------
    contact
        the nested intervals of its family
    path
        P and Q alone; where Q = 0 and bulk strain alone changes, P and the load in whose terms
        the memory curve is
    bulk, turning
        stresses of both bodies, tilt and moment as paths over the same time; None for none
    moment_given
        whether `turning` states the moment
    neglected
        the loads that are below rounding and were left out, each with its size over the load
        that makes its edge slip
    """

    contact: TiltedProfile
    path: LoadPath
    bulk: LoadPath | None
    turning: LoadPath | None
    moment_given: bool
    neglected: Mapping[str, float] = field(default_factory=dict)

    def series(self, time: Array, load: Array) -> dict[str, Array]:
        """Bulk stresses, tilt, moment, contact edges and normal approach at instants (n,) with the
        normal loads (n,).
        """
        # Somebody else's instant may be before the start by rounding.
        inside, contact = np.maximum(time, self.path.start), self.contact
        lower, upper = self.bulk.at(inside) if self.bulk is not None else np.zeros((2, len(time)))
        tilt, moment = (
            self.turning.at(inside) if self.turning is not None else np.zeros((2, len(time)))
        )
        if self.moment_given:
            tilt = contact.tilt_under(load, moment)
        m, c = contact.under(load, tilt)
        return {
            "bulk_stress_lower": lower,
            "bulk_stress_upper": upper,
            "tilt": tilt,
            "moment": moment if self.moment_given else contact.moment(m, c, load, tilt),
            "contact_edges": np.stack([m - c, m + c], axis=-1),
            "normal_approach": contact.approach(m, c, load, tilt),
        }


def strain_of(materials: Materials) -> tuple[float, float]:
    """What the bulk stress of the lower and of the upper body adds to eps: 1/E' and -1/E', E' =
    E/(1 - nu^2) (plane strain).

    >>> from scenes import Elastic
    >>> strain_of(
    ...     Materials(
    ...         lower=Elastic(young_modulus=0.91, poisson_ratio=0.3),
    ...         upper=Elastic(young_modulus=2, poisson_ratio=0),
    ...     )
    ... )
    (1.0, -0.5)
    """
    lower, upper = (
        (1 - body.poisson_ratio**2) / body.young_modulus
        for body in (materials.lower, materials.upper)
    )
    return lower, -upper


def one_curve(scene: Scene, path: LoadPath | None = None) -> OneCurve | None:
    """The scene's path, or `path`, where its memory is one curve: alpha = alpha_0 + kappa P, eps =
    eps_0 + kappa Q, nested.

    At constant P large bulk strain is one as well, and bulk strain alone, as long as the stick
    zones recede at both ends: see `opposite_slip`.

    While the load is pressed on at first, with no Q and no change of bulk strain, the tilt may do
    what it will: nothing is sheared, and nothing is remembered. None where there is another memory,
    or intervals are not nested.

    Raises
    ------
    InputError
        For a profile that bends down somewhere, a contact that leaves the profile.
    """
    path = path or scene.load.path()
    profile = scene.profile
    legs = (*path.initial_loading, *path.cycle)
    shape = convex_profile(profile)
    compliance = 2 / composite_modulus(scene.material)
    datum = profile.datum_length
    friction = scene.friction.coefficient
    strain = strain_of(scene.material)
    upright = TiltedProfile(NestedIntervals(shape, compliance, 0.0, 0.0, math.inf), datum)
    samples = [_sampled(leg, upright if path.moment_given else None, strain) for leg in legs]
    sizes = LoadSizes.of(np.concatenate(samples, axis=1), shape, compliance, friction)
    first = 0
    while first < len(path.initial_loading) and _presses_only(samples[first], sizes):
        first += 1
    p, q, eps, alpha = np.concatenate(samples[first:] or [samples[-1][:, -1:]], axis=1)
    turned = np.isfinite(alpha)
    most = float(np.max(p))
    neglected: dict[str, float] = {}
    # At constant P the stick zones of a parabola are nested where contacts are not.
    still = shape.radius is not None and friction > 0 and np.ptp(p) <= _ROUNDING * most
    begin = float(eps[0])
    pulled = np.ptp(eps) > sizes.strain_rounding
    alone = still and pulled and not np.max(np.abs(q)) > sizes.shear_rounding
    if alone:  # a load in proportion to the bulk strain, of half f P at most, takes the place of Q
        if np.any(q):
            neglected["tangential load"] = float(np.max(np.abs(q))) / (friction * most)
        q = (eps - begin) * (friction * most / 2 / float(np.max(np.abs(eps - begin))))
    if np.ptp(q) > sizes.shear_rounding:
        slope = _slope_of(q, eps, sizes.strain_rounding)
    else:
        slope = _slope_of(p[turned], alpha[turned], sizes.tilt_rounding)
    tilt = float(np.mean(alpha[turned] - slope * p[turned])) if np.any(turned) else 0.0
    strain_apart = float(np.ptp(eps - slope * q))
    tilt_apart = float(np.max(np.abs(alpha[turned] - tilt - slope * p[turned]), initial=0.0))
    if strain_apart > sizes.strain_rounding + _ROUNDING * abs(slope) * np.max(np.abs(q)):
        return None
    if tilt_apart > sizes.tilt_rounding + _ROUNDING * abs(slope) * np.max(p):
        return None
    # What is the last digits of a load itself is no load that was left out.
    if strain_apart > _ROUNDING * np.max(np.abs(eps)):
        neglected["bulk stress"] = strain_apart / sizes.strain
    if tilt_apart > _ROUNDING * np.max(np.abs(alpha[turned])):
        neglected["tilt"] = tilt_apart / sizes.tilt
    contact = TiltedProfile(NestedIntervals(shape, compliance, tilt, slope, most), datum)
    if alone or not contact.is_nested(most):
        if not still:
            return None
        reach = float(np.max(np.abs(q)))
        share = 0.0 if alone else 1.0
        contact = OppositeSlip(
            contact.intervals, datum, friction=friction, reach=reach, share=share
        )
        try:
            if not contact.is_nested(most):
                return None
        except (ArithmeticError, Unresolved):
            return None
    bare = [replace(leg, bulk=None, turning=None) for leg in legs]
    if alone:
        driven = [_driven(leg, strain, begin, slope) for leg in legs]
        if None in driven[first:]:
            return None
        bare[first:] = driven[first:]  # type: ignore[assignment]
    loading = len(path.initial_loading)
    only = LoadPath(tuple(bare[:loading]), tuple(bare[loading:]))
    bulk = path.companion("bulk")
    turning = path.companion("turning")
    return OneCurve(contact, only, bulk, turning, path.moment_given, neglected)


@dataclass(frozen=True)
class LoadSizes:
    """What bulk strain, tilt and Q are measured by along a path, a the half-width at its largest
    load P.

    Attributes
    ----------
    strain, tilt
        A f P/(pi a) and A P/(pi a): of the order of what makes a whole edge of contact slip, or
        lift
    strain_rounding, tilt_rounding, shear_rounding
        below it a change of bulk strain, tilt and Q changes no digit
    """

    strain: float
    tilt: float
    strain_rounding: float
    tilt_rounding: float
    shear_rounding: float

    @property
    def rounding(self) -> Array:
        """Of P, Q, eps and alpha, (4,)."""
        return np.array(
            [self.shear_rounding, self.shear_rounding, self.strain_rounding, self.tilt_rounding]
        )

    @classmethod
    def of(
        cls, samples: Array, shape: ConvexProfile, compliance: float, friction: float
    ) -> LoadSizes:
        """Of P, Q, eps and alpha (4, n)."""
        p, q, eps, alpha = samples
        turned = np.isfinite(alpha)
        last = int(np.argmax(p))
        most = float(p[last])
        half = float(shape.contact(compliance * most, alpha[last] if turned[last] else 0.0)[1])
        tilt = compliance * most / (math.pi * half) if half > 0 else 0.0
        strain = friction * tilt
        return cls(
            strain=strain,
            tilt=tilt,
            strain_rounding=_ROUNDING * max(float(np.max(np.abs(eps))), strain),
            tilt_rounding=_ROUNDING
            * max(float(np.max(np.abs(alpha), where=turned, initial=0.0)), tilt),
            shear_rounding=_ROUNDING * max(float(np.max(np.abs(q))), friction * most),
        )


def cycle_samples(scene: Scene) -> Array:
    """P, Q, eps and alpha at instants of the cycle in order, all turning points among them, (4,
    n).
    """
    path = scene.load.path()
    upright = None
    if path.moment_given:
        shape = convex_profile(scene.profile)
        product = 2 / composite_modulus(scene.material)
        upright = TiltedProfile(
            NestedIntervals(shape, product, 0.0, 0.0, math.inf), scene.profile.datum_length
        )
    return np.concatenate(
        [_sampled(leg, upright, strain_of(scene.material)) for leg in path.cycle], axis=1
    )


def steady_curve(scene: Scene) -> OneCurve | None:
    """The scene's cycle where the memory of the cycle alone is one curve, behind a loading that
    presses first and shears then.

    What changes in a steady cycle of like bodies does not depend on how it was reached, and so
    neither W nor W(x) does (Andersson, Barber and Ponter, 2014); the traction that stays locked in
    the permanent stick zone does.
    """
    path, strain = scene.load.path(), strain_of(scene.material)
    if not path.cycle:
        return None
    _, shears, strains, _ = np.concatenate(
        [_sampled(replace(leg, turning=None), None, strain) for leg in path.cycle], axis=1
    )
    begin, end = path.start, path.cycle_start
    middle, rest = (begin + end) / 2, path.cycle[0]
    p, q = map(float, rest.loads(end))
    pressed, sheared = (
        StraightSegment(begin, middle, (0.0, 0.0), (p, 0.0)),
        StraightSegment(middle, end, (p, 0.0), (p, q)),
    )
    if rest.bulk is not None:
        lower, upper = map(float, rest.bulk.loads(end))
        before = lower - _slope_of(shears, strains) * q / strain[0], upper
        pressed = replace(pressed, bulk=StraightSegment(begin, middle, before, before))
        sheared = replace(sheared, bulk=StraightSegment(middle, end, before, (lower, upper)))
    if rest.turning is not None:
        tilt, moment = map(float, rest.turning.loads(end))
        pressed = replace(
            pressed, turning=StraightSegment(begin, middle, (0.0, 0.0), (tilt, moment))
        )
        sheared = replace(
            sheared, turning=StraightSegment(middle, end, (tilt, moment), (tilt, moment))
        )
    return one_curve(scene, LoadPath((pressed, sheared), path.cycle, path.moment_given))


def _driven(
    leg: LoadSegment, strain: tuple[float, float], begin: float, slope: float
) -> LoadSegment | None:
    """A leg of P and (eps - begin)/slope in place of Q; None where bulk stress is neither a line
    nor a sum of waves.
    """

    def load(stresses: Sequence[float]) -> float:
        return (float(np.dot(strain, stresses)) - begin) / slope

    first, bulk = float(leg.loads(leg.start)[0]), leg.bulk
    if bulk is None or bulk.is_straight:
        ends = [(0.0, 0.0) if bulk is None else bulk.loads(time) for time in (leg.start, leg.end)]
        return StraightSegment(
            leg.start, leg.end, *((first, load([float(one) for one in end])) for end in ends)
        )
    if not isinstance(bulk, HarmonicSegment):
        return None
    waves = np.zeros((2, max(len(bulk.normal), len(bulk.tangential))), dtype=complex)
    for row, own in zip(waves, (bulk.normal, bulk.tangential), strict=True):
        row[: len(own)] = [size * cmath.exp(-1j * phase) for size, phase in own]
    sums = (np.array(strain) @ waves / slope).tolist()
    return HarmonicSegment(
        leg.start,
        leg.end,
        (first, load(bulk.mean)),
        (),
        tuple((abs(one), -cmath.phase(one)) for one in sums),
    )


class Eccentricity(NamedTuple):
    """How far bulk strain moves the stick zone, and whether it is moderate.

    `value` is e = eps R/(f a) of a parabola, eps half the range of the bulk strain in the cycle and
    a the half-width at the largest P: at constant P and in phase the centre of stick moves by e a;
    NaN of other profiles and without friction. `strain` is eps, `limit` = (A/(pi a)) Q with half
    the range of Q: up to it bulk is `moderate`, in phase and at constant P both ends then slip one
    way.
    """

    value: float
    strain: float
    limit: float

    @property
    def moderate(self) -> bool:
        """Whether eps is not above its limit."""
        return self.strain <= self.limit * (1 + _ROUNDING)


def eccentricity(scene: Scene) -> Eccentricity | None:
    """Eccentricity of stick by bulk stress over the cycle, over the whole path where it has none;
    None without bulk stress.

    Like bodies with bulk in one: e = sigma/(4 f p0) (Nowell and Hills 1987). It is a measure, and
    no bound: with P, Q or bulk out of phase the ends may slip opposite ways although bulk is
    moderate.

    >>> from scenes import load_scene
    >>> scene = load_scene("cattaneo-mindlin")
    >>> eccentricity(scene) is None
    True
    """
    path, profile, friction = scene.load.path(), scene.profile, scene.friction.coefficient
    legs = path.cycle or path.initial_loading
    if not path.has_bulk_or_tilt or all(leg.bulk is None for leg in legs):
        return None
    strains = strain_of(scene.material)
    p, q, eps, _ = np.concatenate(
        [_sampled(replace(leg, turning=None), None, strains) for leg in legs], axis=1
    )
    modulus, most = composite_modulus(scene.material), float(np.max(p))
    if profile.symmetric:
        half = float(contact_of(profile, scene.material).half_width(most))
    else:
        half = float(convex_profile(profile).contact(2 / modulus * most, 0.0)[1])
    strain, force = float(np.ptp(eps)) / 2, float(np.ptp(q)) / 2
    value = (
        strain * profile.radius / (friction * half)
        if isinstance(profile, Hertz) and friction > 0
        else math.nan
    )
    return Eccentricity(value, strain, 2 * force / (math.pi * modulus * half))


def followed_path(scene: Scene) -> LoadPath:
    """P and Q of a scene whose memory is one curve: its whole path without bulk stress and tilt.

    Raises
    ------
    InputError
        For another memory, and as `one_curve`.
    """
    path = scene.load.path()
    if not path.has_bulk_or_tilt:
        return path
    family = one_curve(scene)
    if family is None or not family.contact.share:
        raise InputError(NO_ONE_CURVE)
    return family.path


@dataclass(frozen=True, eq=False)
class PathLoads:
    """P, Q, eps and alpha of a load path; of several times at once only within one leg, which is
    that of their mean.

    Attributes
    ----------
    path
        the load path
    strain
        what the bulk stress of the lower and of the upper body adds to eps
    contact
        the profile, for the tilt under a given moment
    """

    path: LoadPath
    strain: tuple[float, float]
    contact: TiltedProfile

    def _place(self, time: float) -> tuple[LoadSegment, float]:
        """The leg at a time, and by how much it is late."""
        late = 0.0
        if self.path.period is not None and time > self.path.cycle_start:
            late = math.floor((time - self.path.cycle_start) / self.path.period) * self.path.period
        legs = (*self.path.initial_loading, *self.path.cycle)
        return next((leg for leg in legs if time - late <= leg.end), legs[-1]), late

    def values(self, time: Array) -> Array:
        """P, Q, eps and alpha at times within one leg, (4, n)."""
        leg, late = self._place(float(np.mean(time)))
        p, q = leg.loads(time - late)
        lower, upper = leg.bulk.loads(time - late) if leg.bulk is not None else (0.0, 0.0)
        tilt, moment = leg.turning.loads(time - late) if leg.turning is not None else (0.0, 0.0)
        eps = self.strain[0] * lower + self.strain[1] * upper
        p, q, eps, tilt, moment, _ = np.broadcast_arrays(p, q, eps, tilt, moment, time)
        if self.path.moment_given:
            tilt = self.contact.tilt_under(p, moment)
        return np.stack([p, q, eps, tilt])

    def stresses(self, time: Array) -> Array:
        """Bulk stress of the lower and of the upper body, (2, n), for any times."""
        stresses = np.zeros((2, len(time)))
        for k, instant in enumerate(time.tolist()):
            leg, late = self._place(instant)
            if leg.bulk is not None:
                stresses[:, k] = leg.bulk.loads(instant - late)
        return stresses

    def turns(self, leg: LoadSegment) -> list[float]:
        """The end of a leg and the turning points of P, Q, eps, tilt and moment in it; one time for
        all that turn together.
        """
        force = Combination(0.0, 1.0)
        turning_points = leg.turning_points(NORMAL_LOAD) + leg.turning_points(force)
        if leg.bulk is not None:
            turning_points += leg.bulk.turning_points(Combination(*self.strain))
        if leg.turning is not None:
            turning_points += leg.turning.turning_points(NORMAL_LOAD) + leg.turning.turning_points(
                force
            )
        turns = [leg.end]
        for time in turning_points:
            if min(abs(time - known) for known in turns) > 1e-6 * (leg.end - leg.start):
                turns.append(time)
        return turns


def _presses_only(samples: Array, sizes: LoadSizes) -> bool:
    """Whether a leg has no Q and no change of bulk strain, to rounding."""
    _, q, eps, _ = samples
    return bool(np.max(np.abs(q)) <= sizes.shear_rounding and np.ptp(eps) <= sizes.strain_rounding)


def _sampled(leg: LoadSegment, upright: TiltedProfile | None, strain: tuple[float, float]) -> Array:
    """P, Q, eps and alpha at instants of a leg, (4, n): enough to tell two legs apart; no alpha
    where a moment has no load.

    `upright` is the contact where the moment is stated.
    """
    parts = [part for part in (leg, leg.bulk, leg.turning) if part is not None]
    turns = max(part.most_turns for part in parts)
    share = (
        np.linspace(0, 1, 3)
        if all(part.is_straight for part in parts)
        else np.linspace(0, 1, _SAMPLES + 2 * turns)
    )
    # The turning points too: the extreme loads and strains are among them.
    turning = leg.turning_points(NORMAL_LOAD) + leg.turning_points(Combination(0.0, 1.0))
    turning += leg.bulk.turning_points(Combination(*strain)) if leg.bulk is not None else []
    time = np.unique(np.append(leg.start + (leg.end - leg.start) * share, turning))
    p, q = leg.loads(time)
    lower, upper = leg.bulk.loads(time) if leg.bulk is not None else (0.0, 0.0)
    tilt, moment = leg.turning.loads(time) if leg.turning is not None else (0.0 * p, 0.0 * p)
    if upright is not None and np.any(moment):
        tilt = np.where(p > 0, upright.tilt_under(*np.broadcast_arrays(p, moment)), np.nan)
    return np.stack([p, q, strain[0] * lower + strain[1] * upper + 0 * p, tilt])


def _slope_of(load: Array, what: Array, rounding: float = 0.0) -> float:
    """Least-squares slope; 0 where the load is constant, or what depends on it is, to its
    `rounding`.
    """
    if (
        not len(load)
        or np.ptp(what) <= rounding
        or np.ptp(load) <= _ROUNDING * np.max(np.abs(load))
    ):
        return 0.0
    away = load - np.mean(load)
    square = float(away @ away)
    return float(away @ what) / square if square > 0 else 0.0


def leaning_profile(scene: Scene) -> tuple[PathLoads, TiltedProfile]:
    """P, Q, eps and alpha of a scene that theory takes, and its profile under any tilt."""
    shape = convex_profile(scene.profile)
    path = scene.load.path()
    largest_load = -math.inf
    for leg in (*path.initial_loading, *path.cycle):
        for time in (leg.end, *leg.turning_points(NORMAL_LOAD)):
            load, _ = leg.loads(time)
            largest_load = max(largest_load, float(load))
    compliance = 2 / composite_modulus(scene.material)
    intervals = NestedIntervals(shape, compliance, 0.0, 0.0, largest_load)
    profile = TiltedProfile(intervals, scene.profile.datum_length)
    return PathLoads(path, strain_of(scene.material), profile), profile
