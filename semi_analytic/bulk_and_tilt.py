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

from scenes import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
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
from scenes.array_types import Array
from scenes.chebyshev import Unresolved
from semi_analytic.elasticity import composite_modulus
from semi_analytic.opposite_slip import OppositeSlip
from semi_analytic.profiles import contact_of, convex_profile
from semi_analytic.tilted_profile import ConvexProfile, NestedIntervals, TiltedProfile

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
        """Values of a contact with bulk stress and tilt at instants (n,), by name: both bulk
        stresses, tilt, moment of the pressure, contact edges and normal approach.

        `load` (n,) is P there. Either the tilt or the moment is prescribed; the other follows.

        # notation: m, c centre and half-length of the contact
        """
        # An instant may be before the start by round-off.
        path_time = np.maximum(time, self.path.start)
        contact = self.contact
        stress_of_lower, stress_of_upper = np.zeros((2, len(time)))
        if self.bulk is not None:
            stress_of_lower, stress_of_upper = self.bulk.at(path_time)
        tilt, moment = np.zeros((2, len(time)))
        if self.turning is not None:
            tilt, moment = self.turning.at(path_time)
        if self.moment_given:
            tilt = contact.tilt_under(load, moment)
        m, c = contact.under(load, tilt)
        return {
            "bulk_stress_lower": stress_of_lower,
            "bulk_stress_upper": stress_of_upper,
            "tilt": tilt,
            "moment": moment if self.moment_given else contact.moment(m, c, load, tilt),
            "contact_edges": np.stack([m - c, m + c], axis=-1),
            "normal_approach": contact.approach(m, c, load, tilt),
        }


def strain_of(materials: Materials) -> tuple[float, float]:
    """Bulk strain eps by a unit of bulk stress in the lower and in the upper body: 1/E' and -1/E',
    with E' = E/(1 - nu^2) (plane strain) [1/stress].

    eps is by how much the lower surface stretches more than the upper one.

    >>> from scenes import Elastic
    >>> strain_of(
    ...     Materials(
    ...         lower=Elastic(young_modulus=0.91, poisson_ratio=0.3),
    ...         upper=Elastic(young_modulus=2, poisson_ratio=0),
    ...     )
    ... )
    (1.0, -0.5)
    """
    lower_compliance = (1 - materials.lower.poisson_ratio**2) / materials.lower.young_modulus
    upper_compliance = (1 - materials.upper.poisson_ratio**2) / materials.upper.young_modulus
    return lower_compliance, -upper_compliance


def one_curve(scene: Scene, path: LoadPath | None = None) -> OneCurve | None:
    """Contact and loads of a path with bulk strain eps and tilt alpha on which one memory curve
    holds what friction remembers; None where no single curve does. A memory curve is the tangential
    force, or the bulk strain, locked in up to each load.

    One curve is enough where alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q with one kappa,
    and contacts are nested. `path` is that of the scene by default. At constant P large bulk strain
    has one curve as well, and so has bulk strain alone, as long as the stick zones recede at both
    ends.

    While P is applied at first, with no Q and no change of bulk strain, the tilt may vary freely:
    nothing is sheared, and nothing is remembered.

    # notation: p, q, eps, alpha samples (n,) of P, Q, bulk strain and tilt along the path

    Raises
    ------
    InputError
        For a profile that bends down somewhere, a contact that leaves the profile.
    """
    path = path or scene.load.path()
    segments = (*path.initial_loading, *path.cycle)
    loading_count = len(path.initial_loading)
    convex_shape = convex_profile(scene.profile)
    compliance = 2 / composite_modulus(scene.material)
    datum_length = scene.profile.datum_length
    friction = scene.friction.coefficient
    strain_per_stress = strain_of(scene.material)
    upright_profile = TiltedProfile(
        NestedIntervals(convex_shape, compliance, 0.0, 0.0, math.inf), datum_length
    )
    samples_of_segments = [
        _sampled(segment, upright_profile if path.moment_given else None, strain_per_stress)
        for segment in segments
    ]
    load_sizes = LoadSizes.of(
        np.concatenate(samples_of_segments, axis=1), convex_shape, compliance, friction
    )
    first_shearing_segment = _first_shearing_segment(
        samples_of_segments[:loading_count], load_sizes
    )
    last_sample = samples_of_segments[-1][:, -1:]
    p, q, eps, alpha = np.concatenate(
        samples_of_segments[first_shearing_segment:] or [last_sample], axis=1
    )
    largest_load = float(np.max(p))
    neglected: dict[str, float] = {}
    # At constant P the stick zones of a parabola are nested where contacts are not.
    is_parabola = convex_shape.radius is not None
    may_slip_apart = is_parabola and friction > 0 and np.ptp(p) <= _ROUNDING * largest_load
    first_strain = float(eps[0])
    strain_changes = np.ptp(eps) > load_sizes.strain_rounding
    has_shear_force = np.max(np.abs(q)) > load_sizes.shear_rounding
    is_strain_alone = bool(may_slip_apart and strain_changes and not has_shear_force)
    if is_strain_alone:
        # A load in proportion to the bulk strain, of half f P at most, takes the place of Q.
        if np.any(q):
            neglected["tangential load"] = float(np.max(np.abs(q))) / (friction * largest_load)
        largest_change = float(np.max(np.abs(eps - first_strain)))
        q = (eps - first_strain) * (friction * largest_load / 2 / largest_change)
    relation = _AffineRelation.fitted(p, q, eps, alpha, load_sizes)
    if not relation.holds:
        return None
    neglected |= relation.neglected
    intervals = NestedIntervals(
        convex_shape, compliance, relation.tilt_without_load, relation.slope, largest_load
    )
    contact = _contact_with_one_curve(
        intervals,
        datum_length,
        friction,
        largest_shear=float(np.max(np.abs(q))),
        is_strain_alone=is_strain_alone,
        may_slip_apart=bool(may_slip_apart),
    )
    if contact is None:
        return None
    first_segment_by_strain = first_shearing_segment if is_strain_alone else len(segments)
    segments_of_curve: list[LoadSegment | None] = [
        replace(segment, bulk=None, turning=None) for segment in segments[:first_segment_by_strain]
    ]
    segments_of_curve += [
        _leg_by_strain(segment, strain_per_stress, first_strain, relation.slope)
        for segment in segments[first_segment_by_strain:]
    ]
    known_segments = [segment for segment in segments_of_curve if segment is not None]
    if len(known_segments) < len(segments):
        return None
    return OneCurve(
        contact=contact,
        path=LoadPath(tuple(known_segments[:loading_count]), tuple(known_segments[loading_count:])),
        bulk=path.companion("bulk"),
        turning=path.companion("turning"),
        moment_given=path.moment_given,
        neglected=neglected,
    )


def _contact_with_one_curve(
    intervals: NestedIntervals,
    datum_length: float,
    friction: float,
    largest_shear: float,
    is_strain_alone: bool,
    may_slip_apart: bool,
) -> TiltedProfile | None:
    """The contact whose memory of friction is one curve: that of nested contact intervals, or the
    one of a parabola whose ends slip opposite ways; None where neither exists.

    Parameters
    ----------
    intervals
        contact intervals under the loads of the path
    datum_length
        distance at which displacements count as 0 [length]
    largest_shear
        the largest |Q|, or of the load in its place [force per thickness]
    is_strain_alone
        whether bulk strain alone shears the contact
    may_slip_apart
        whether the profile is a parabola, and P constant
    """
    contact = TiltedProfile(intervals, datum_length)
    if not is_strain_alone and contact.is_nested(intervals.largest_load):
        return contact
    if not may_slip_apart:
        return None
    share_of_shear = 0.0 if is_strain_alone else 1.0
    return _slipping_apart(intervals, datum_length, friction, largest_shear, share_of_shear)


def _first_shearing_segment(samples_of_loading: list[Array], load_sizes: LoadSizes) -> int:
    """Number of the first segment of the initial loading that shears the contact, by Q or by a
    change of bulk strain; the number of segments where none does.

    `samples_of_loading` are P, Q, eps and alpha of each segment, (4, n).
    """
    for number, samples in enumerate(samples_of_loading):
        if not _presses_only(samples, load_sizes):
            return number
    return len(samples_of_loading)


class _AffineRelation(NamedTuple):
    """alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q with one kappa, fitted to samples of a
    load path, and whether they hold.

    Attributes
    ----------
    slope, tilt_without_load
        kappa [1/load], alpha_0 [rad]
    holds
        whether strain and tilt of all samples are on the lines to rounding
    neglected
        "bulk stress" and "tilt": deviations from the lines that are more than round-off of strain
        or tilt themselves, each over the size that makes an edge slip or lift
    """

    slope: float
    tilt_without_load: float
    holds: bool
    neglected: dict[str, float]

    @classmethod
    def fitted(
        cls, p: Array, q: Array, eps: Array, alpha: Array, load_sizes: LoadSizes
    ) -> _AffineRelation:
        """The slope kappa of alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q, fitted to samples
        (n,) of a load path, and whether both hold to round-off.

        kappa is that of eps over Q where Q changes, else of alpha over P. A tilt that is not known
        is NaN.

        Parameters
        ----------
        p, q
            P and Q [force per thickness]
        eps
            bulk strain, of both bodies together
        alpha
            tilt [rad]
        load_sizes
            below which size a change of each is round-off
        """
        has_tilt_value = np.isfinite(alpha)
        p_with_tilt = p[has_tilt_value]
        known_tilt = alpha[has_tilt_value]
        if np.ptp(q) > load_sizes.shear_rounding:
            slope = _slope_of(q, eps, load_sizes.strain_rounding)
        else:
            slope = _slope_of(p_with_tilt, known_tilt, load_sizes.tilt_rounding)
        tilt_without_load = 0.0
        if np.any(has_tilt_value):
            tilt_without_load = float(np.mean(known_tilt - slope * p_with_tilt))
        strain_deviation = float(np.ptp(eps - slope * q))
        tilt_deviations = np.abs(known_tilt - tilt_without_load - slope * p_with_tilt)
        tilt_deviation = float(np.max(tilt_deviations, initial=0.0))
        strain_limit = load_sizes.strain_rounding + _ROUNDING * abs(slope) * np.max(np.abs(q))
        tilt_limit = load_sizes.tilt_rounding + _ROUNDING * abs(slope) * np.max(p)
        holds = not (strain_deviation > strain_limit or tilt_deviation > tilt_limit)
        neglected = {}
        if holds:
            # What is the last digits of a load itself is no load that was left out.
            if strain_deviation > _ROUNDING * np.max(np.abs(eps)):
                neglected["bulk stress"] = strain_deviation / load_sizes.strain
            if tilt_deviation > _ROUNDING * np.max(np.abs(known_tilt)):
                neglected["tilt"] = tilt_deviation / load_sizes.tilt
        return cls(slope, tilt_without_load, holds, neglected)


def _slipping_apart(
    intervals: NestedIntervals,
    datum_length: float,
    friction: float,
    largest_shear: float,
    share_of_shear: float,
) -> OppositeSlip | None:
    """The contact of a parabola at constant P whose ends slip opposite ways under bulk strain; None
    where its stick zones are not nested, or cannot be resolved.

    They must be nested up to the largest shear force of the path.

    Parameters
    ----------
    intervals
        nested intervals of contact of the parabola
    datum_length
        distance at which displacements count as 0 [length]
    friction
        f, coefficient of friction
    largest_shear
        the largest |Q| [force per thickness]
    share_of_shear
        0 where bulk strain alone changes and a load in proportion stands for Q, else 1
    """
    contact = OppositeSlip(
        intervals, datum_length, friction=friction, reach=largest_shear, share=share_of_shear
    )
    try:
        return contact if contact.is_nested(intervals.largest_load) else None
    except (ArithmeticError, Unresolved):
        return None


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
        """Sizes by which bulk strain, tilt and Q of a load path are judged, from samples of P, Q,
        bulk strain and tilt along it, (4, n).

        They are the tilt that lifts an edge and the strain that makes one slip, at the largest P,
        and the round-off of each. An unknown tilt is NaN. `shape` is the profile, `compliance` A =
        2/E*, `friction` f.

        # notation: p, q, eps, alpha samples (n,) of P, Q, bulk strain and tilt
        """
        p, q, eps, alpha = samples
        has_tilt = np.isfinite(alpha)
        number_of_largest = int(np.argmax(p))
        largest_load = float(p[number_of_largest])
        tilt_there = alpha[number_of_largest] if has_tilt[number_of_largest] else 0.0
        half_width = float(shape.contact(compliance * largest_load, tilt_there)[1])
        lifting_tilt = 0.0
        if half_width > 0:
            lifting_tilt = compliance * largest_load / (math.pi * half_width)
        slipping_strain = friction * lifting_tilt
        largest_tilt = float(np.max(np.abs(alpha), where=has_tilt, initial=0.0))
        return cls(
            strain=slipping_strain,
            tilt=lifting_tilt,
            strain_rounding=_ROUNDING * max(float(np.max(np.abs(eps))), slipping_strain),
            tilt_rounding=_ROUNDING * max(largest_tilt, lifting_tilt),
            shear_rounding=_ROUNDING * max(float(np.max(np.abs(q))), friction * largest_load),
        )


def cycle_samples(scene: Scene) -> Array:
    """Loads at instants of a scene's cycle in order, all turning points among them, as rows (4, n):
    P, Q, bulk strain and tilt.

    A tilt that is not prescribed follows from the moment.
    """
    path = scene.load.path()
    upright_profile = None
    if path.moment_given:
        shape = convex_profile(scene.profile)
        unit_compliance = 2 / composite_modulus(scene.material)
        upright_profile = TiltedProfile(
            NestedIntervals(shape, unit_compliance, 0.0, 0.0, math.inf), scene.profile.datum_length
        )
    return np.concatenate(
        [_sampled(leg, upright_profile, strain_of(scene.material)) for leg in path.cycle], axis=1
    )


def steady_curve(scene: Scene) -> OneCurve | None:
    """Contact and loads of a scene's cycle where one memory curve holds what friction remembers of
    the cycle alone, after an initial loading that presses first and shears then; None else. A
    memory curve is the tangential force, or the bulk strain, locked in up to each load.

    What changes in a steady cycle of like bodies does not depend on how it was reached, and so
    neither W nor W(x) does (Andersson, Barber and Ponter, 2014); the traction that stays locked in
    the permanent stick zone does.
    """
    path = scene.load.path()
    strain_per_stress = strain_of(scene.material)
    if not path.cycle:
        return None
    _, forces, strains, _ = np.concatenate(
        [
            _sampled(replace(segment, turning=None), None, strain_per_stress)
            for segment in path.cycle
        ],
        axis=1,
    )
    path_start = path.start
    cycle_start = path.cycle_start
    middle_time = (path_start + cycle_start) / 2
    first_segment = path.cycle[0]
    load_at_cycle_start, force_at_cycle_start = map(float, first_segment.loads(cycle_start))
    pressing = StraightSegment(path_start, middle_time, (0.0, 0.0), (load_at_cycle_start, 0.0))
    shearing = StraightSegment(
        middle_time,
        cycle_start,
        (load_at_cycle_start, 0.0),
        (load_at_cycle_start, force_at_cycle_start),
    )
    if first_segment.bulk is not None:
        stress_of_lower, stress_of_upper = map(float, first_segment.bulk.loads(cycle_start))
        stress_before = (
            stress_of_lower
            - _slope_of(forces, strains) * force_at_cycle_start / strain_per_stress[0]
        )
        stresses_before = (stress_before, stress_of_upper)
        pressing = replace(
            pressing,
            bulk=StraightSegment(path_start, middle_time, stresses_before, stresses_before),
        )
        shearing = replace(
            shearing,
            bulk=StraightSegment(
                middle_time, cycle_start, stresses_before, (stress_of_lower, stress_of_upper)
            ),
        )
    if first_segment.turning is not None:
        tilt, moment = map(float, first_segment.turning.loads(cycle_start))
        pressing = replace(
            pressing, turning=StraightSegment(path_start, middle_time, (0.0, 0.0), (tilt, moment))
        )
        shearing = replace(
            shearing,
            turning=StraightSegment(middle_time, cycle_start, (tilt, moment), (tilt, moment)),
        )
    return one_curve(scene, LoadPath((pressing, shearing), path.cycle, path.moment_given))


def _leg_by_strain(
    leg: LoadSegment,
    strain_per_stress: tuple[float, float],
    strain_without_load: float,
    slope: float,
) -> LoadSegment | None:
    """A segment of a load path at constant P in which a load in proportion to the bulk strain eps,
    (eps - strain_without_load)/slope, takes the place of Q.

    None where bulk stress is neither a line nor a sum of waves over time.

    Parameters
    ----------
    leg
        the segment of the path, with its bulk stresses
    strain_per_stress
        bulk strain eps by a unit bulk stress of the lower and of the upper body [1/stress]
    strain_without_load
        eps at which that load is 0
    slope
        of eps over the load that stands for Q
    """

    def load_of(stresses: Sequence[float]) -> float:
        return (float(np.dot(strain_per_stress, stresses)) - strain_without_load) / slope

    normal_load = float(leg.loads(leg.start)[0])
    bulk = leg.bulk
    if bulk is None:
        constant_load = load_of((0.0, 0.0))
        return StraightSegment(
            leg.start, leg.end, (normal_load, constant_load), (normal_load, constant_load)
        )
    if bulk.is_straight:
        first_load = load_of([float(stress) for stress in bulk.loads(leg.start)])
        last_load = load_of([float(stress) for stress in bulk.loads(leg.end)])
        return StraightSegment(
            leg.start, leg.end, (normal_load, first_load), (normal_load, last_load)
        )
    if not isinstance(bulk, HarmonicSegment):
        return None
    # A segment of bulk stresses stores that of the lower body where others have P, that of the
    # upper body where they have Q.
    waves_of_bodies = (bulk.normal, bulk.tangential)
    phasors = np.zeros((2, max(map(len, waves_of_bodies))), dtype=complex)
    for phasors_of_body, waves in zip(phasors, waves_of_bodies, strict=True):
        phasors_of_body[: len(waves)] = [size * cmath.exp(-1j * phase) for size, phase in waves]
    load_phasors = (np.array(strain_per_stress) @ phasors / slope).tolist()
    return HarmonicSegment(
        leg.start,
        leg.end,
        (normal_load, load_of(bulk.mean)),
        (),
        tuple((abs(phasor), -cmath.phase(phasor)) for phasor in load_phasors),
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
    """How far bulk stress moves the stick zone out of the middle in a cycle, or along a path
    without a cycle; None without bulk stress.

    Like bodies with bulk in one: e = sigma/(4 f p0) (Nowell and Hills 1987). It is a measure, and
    no bound: with P, Q or bulk out of phase the ends may slip opposite ways although bulk is
    moderate.

    # notation: p, q, eps samples (n,) of P, Q and bulk strain

    >>> from scenes import load_scene
    >>> scene = load_scene("cattaneo-mindlin")
    >>> eccentricity(scene) is None
    True
    """
    path = scene.load.path()
    profile = scene.profile
    friction = scene.friction.coefficient
    segments = path.cycle or path.initial_loading
    if not path.has_bulk_or_tilt or all(segment.bulk is None for segment in segments):
        return None
    strains = strain_of(scene.material)
    p, q, eps, _ = np.concatenate(
        [_sampled(replace(segment, turning=None), None, strains) for segment in segments], axis=1
    )
    modulus = composite_modulus(scene.material)
    largest_load = float(np.max(p))
    if profile.symmetric:
        half_width = float(contact_of(profile, scene.material).half_width(largest_load))
    else:
        half_width = float(convex_profile(profile).contact(2 / modulus * largest_load, 0.0)[1])
    strain_amplitude = float(np.ptp(eps)) / 2
    force_amplitude = float(np.ptp(q)) / 2
    stick_eccentricity = math.nan
    if isinstance(profile, Hertz) and friction > 0:
        stick_eccentricity = strain_amplitude * profile.radius / (friction * half_width)
    return Eccentricity(
        stick_eccentricity, strain_amplitude, 2 * force_amplitude / (math.pi * modulus * half_width)
    )


def followed_path(scene: Scene) -> LoadPath:
    """P and Q of a scene on which one memory curve holds what friction remembers: the scene's own
    path, or, with bulk stress and tilt, that of the contact that has one curve. A memory curve is
    the tangential force, or the bulk strain, locked in up to each load.

    Raises
    ------
    InputError
        For a path with bulk stress or tilt that has no single curve, a profile that bends down
        somewhere, a contact that leaves the profile.
    """
    path = scene.load.path()
    if not path.has_bulk_or_tilt:
        return path
    contact_and_path = one_curve(scene)
    if contact_and_path is None or not contact_and_path.contact.share:
        raise InputError(NO_ONE_CURVE)
    return contact_and_path.path


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
        path = self.path
        delay = 0.0
        if path.period is not None and time > path.cycle_start:
            delay = math.floor((time - path.cycle_start) / path.period) * path.period
        legs = (*path.initial_loading, *path.cycle)
        return next((leg for leg in legs if time - delay <= leg.end), legs[-1]), delay

    def values(self, time: Array) -> Array:
        """P, Q, bulk strain eps and tilt alpha at times (n,) within one segment of the load path,
        as rows of (4, n).

        eps is by how much the bulk stresses stretch the lower surface more than the upper one. A
        tilt that is not prescribed follows from the moment.
        """
        segment, delay = self._place(float(np.mean(time)))
        time_in_segment = time - delay
        normal_load, tangential_load = segment.loads(time_in_segment)
        stress_of_lower, stress_of_upper = _companion_loads(segment.bulk, time_in_segment)
        tilt, moment = _companion_loads(segment.turning, time_in_segment)
        strain = self.strain[0] * stress_of_lower + self.strain[1] * stress_of_upper
        normal_load, tangential_load, strain, tilt, moment, _ = np.broadcast_arrays(
            normal_load, tangential_load, strain, tilt, moment, time
        )
        if self.path.moment_given:
            tilt = self.contact.tilt_under(normal_load, moment)
        return np.stack([normal_load, tangential_load, strain, tilt])

    def stresses(self, time: Array) -> Array:
        """Bulk stress of the lower and of the upper body, (2, n), for any times."""
        stresses = np.zeros((2, len(time)))
        for k, instant in enumerate(time.tolist()):
            leg, delay = self._place(instant)
            if leg.bulk is not None:
                stresses[:, k] = leg.bulk.loads(instant - delay)
        return stresses

    def turns(self, leg: LoadSegment) -> list[float]:
        """The end of a segment of the load path and the turning points of P, Q, bulk strain, tilt
        and moment in it; one time for all that turn together.
        """
        turning_points = leg.turning_points(NORMAL_LOAD)
        turning_points += leg.turning_points(TANGENTIAL_LOAD)
        if leg.bulk is not None:
            turning_points += leg.bulk.turning_points(Combination(*self.strain))
        if leg.turning is not None:
            turning_points += leg.turning.turning_points(NORMAL_LOAD)
            turning_points += leg.turning.turning_points(TANGENTIAL_LOAD)
        different_times = [leg.end]
        for time in turning_points:
            distance = min(abs(time - turn) for turn in different_times)
            if distance > 1e-6 * (leg.end - leg.start):
                different_times.append(time)
        return different_times


def _presses_only(samples: Array, sizes: LoadSizes) -> bool:
    """Whether a leg has no Q and no change of bulk strain, to rounding."""
    _, q, eps, _ = samples
    return bool(np.max(np.abs(q)) <= sizes.shear_rounding and np.ptp(eps) <= sizes.strain_rounding)


def _sampled(
    leg: LoadSegment, upright_profile: TiltedProfile | None, strain_per_stress: tuple[float, float]
) -> Array:
    """P, Q, bulk strain eps and tilt alpha at instants of a segment of the load path, (4, n):
    enough to distinguish two segments, turning points included.

    `upright_profile` is the contact where the moment is prescribed, from which the tilt follows;
    alpha is NaN where a moment has no load. `strain_per_stress` is eps by a unit bulk stress of the
    lower and of the upper body [1/stress].

    # notation: p, q values of P and Q
    """
    courses_of_loads = [course for course in (leg, leg.bulk, leg.turning) if course is not None]
    most_turns = max(course.most_turns for course in courses_of_loads)
    n_instants = (
        3 if all(course.is_straight for course in courses_of_loads) else _SAMPLES + 2 * most_turns
    )
    spread_times = leg.start + (leg.end - leg.start) * np.linspace(0, 1, n_instants)
    # The turning points too: the extreme loads and strains are among them.
    turning_times = leg.turning_points(NORMAL_LOAD) + leg.turning_points(TANGENTIAL_LOAD)
    if leg.bulk is not None:
        turning_times += leg.bulk.turning_points(Combination(*strain_per_stress))
    time = np.unique(np.append(spread_times, turning_times))
    p, q = leg.loads(time)
    stress_of_lower, stress_of_upper = _companion_loads(leg.bulk, time)
    tilt, moment = _companion_loads(leg.turning, time)
    if upright_profile is not None and np.any(moment):
        tilt = np.where(p > 0, upright_profile.tilt_under(*np.broadcast_arrays(p, moment)), np.nan)
    return np.stack(
        [
            p,
            q,
            strain_per_stress[0] * stress_of_lower + strain_per_stress[1] * stress_of_upper,
            tilt,
        ]
    )


def _companion_loads(companion: LoadSegment | None, time: Array) -> tuple[Array, Array]:
    """Both values of a leg's `bulk` or `turning` at times, shape of `time`; 0 where it has none."""
    if companion is None:
        return np.zeros(np.shape(time)), np.zeros(np.shape(time))
    first_load, second_load = companion.loads(time)
    zeros = np.zeros(np.shape(time))
    return first_load + zeros, second_load + zeros


def _slope_of(load: Array, values: Array, rounding: float = 0.0) -> float:
    """Least-squares slope of values over a load, (n,) each; 0 where the load is constant to
    rounding, or the values are to their `rounding`.
    """
    if not len(load) or np.ptp(values) <= rounding:
        return 0.0
    if np.ptp(load) <= _ROUNDING * np.max(np.abs(load)):
        return 0.0
    deviations = load - np.mean(load)
    square = float(deviations @ deviations)
    return float(deviations @ values) / square if square > 0 else 0.0


def leaning_profile(scene: Scene) -> tuple[PathLoads, TiltedProfile]:
    """Loads of a scene over time, with bulk strain and tilt, and its profile as a contact that can
    be tilted.

    The contact is set up to the largest normal load of the path.
    """
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
