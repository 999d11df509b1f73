"""Bulk stress and tilt: which load paths have nested contact intervals and one memory curve, so
that the superposition of Ciavarella and Jaeger holds.

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
from scenes.chebyshev import UnresolvedError
from scenes.frozen import validated
from semi_analytic.elasticity import composite_modulus
from semi_analytic.opposite_slip import OppositeSlip
from semi_analytic.profiles import contact_of, convex_profile
from semi_analytic.tilted_profile import ConvexProfile, NestedIntervals, TiltedProfile

# Share of the largest value, or of what would make a whole edge slip, within which two affine
# functions are one.
_ROUND_OFF_SHARE = 1e-11
# Instants of a curved segment of the load path that are compared, besides two for each turning
# point that it may have.
_INSTANTS_OF_CURVED_SEGMENT = 40

REASON_WITHOUT_ONE_CURVE = (
    "load: events are turns of the one memory curve, and these loads have none: that takes bulk"
    " strain that is kappa Q and tilt that is kappa P, with the same kappa and each with a"
    " constant, and contact intervals that stay nested; `solve` answers them"
)
"""Why events are refused of a scene that `one_curve` does not take."""


@dataclass(frozen=True, eq=False)
class OneCurve:
    """A load path with bulk stress and tilt whose frictional state is one memory curve: the
    tangential force, or the bulk strain, locked in up to each normal load.

    Attributes
    ----------
    contact
        the nested intervals of contact, or of stick, on which the curve stands
    path
        P and Q alone; where Q = 0 and bulk strain alone changes, a load in proportion to that
        change replaces Q
    bulk, tilt_and_moment
        stresses of both bodies, tilt and moment as paths over the same time; None for none
    moment_is_given
        whether `tilt_and_moment` states the moment
    neglected_loads
        loads below round-off that were left out, each over the load that makes an edge of
        contact slip or lift
    """

    contact: TiltedProfile
    path: LoadPath
    bulk: LoadPath | None
    tilt_and_moment: LoadPath | None
    moment_is_given: bool
    neglected_loads: Mapping[str, float] = field(default_factory=dict)

    def values_over_time(self, time: Array, load: Array) -> dict[str, Array]:
        """Bulk stress of both bodies, tilt [rad], moment of the pressure, contact edges (n, 2) and
        normal approach [length], by name. They are at instants (n,) of a load path with bulk stress
        and tilt.

        `load` (n,) is P there. Either the tilt or the moment is prescribed; the other follows from
        the contact. Bulk stress and tilt are 0 if not prescribed.
        """
        # An instant may be before the start by round-off.
        path_time = np.maximum(time, self.path.start)
        contact = self.contact
        stress_of_lower_body, stress_of_upper_body = np.zeros((2, len(time)))
        if self.bulk is not None:
            stress_of_lower_body, stress_of_upper_body = self.bulk.at(path_time)
        tilt, moment = np.zeros((2, len(time)))
        if self.tilt_and_moment is not None:
            tilt, moment = self.tilt_and_moment.at(path_time)
        if self.moment_is_given:
            tilt = contact.tilt_under(load, moment)
        middle, half_width = contact.centre_and_half_width_under(load, tilt)
        if not self.moment_is_given:
            moment = contact.moment(middle, half_width, load, tilt)
        return {
            "bulk_stress_lower": stress_of_lower_body,
            "bulk_stress_upper": stress_of_upper_body,
            "tilt": tilt,
            "moment": moment,
            "contact_edges": np.stack([middle - half_width, middle + half_width], axis=-1),
            "normal_approach": contact.approach(middle, half_width, load, tilt),
        }


def strain_per_stress_of(materials: Materials) -> tuple[float, float]:
    """Bulk strain eps by a unit of bulk stress in the lower and in the upper body: 1/E' and -1/E',
    with E' = E/(1 - nu^2) (plane strain) [1/stress].

    eps is by how much the lower surface stretches more than the upper one.

    >>> from scenes import Elastic
    >>> strain_per_stress_of(
    ...     Materials(
    ...         lower=Elastic(young_modulus=0.91, poisson_ratio=0.3),
    ...         upper=Elastic(young_modulus=2, poisson_ratio=0),
    ...     )
    ... )
    (1.0, -0.5)
    """
    lower_strain_per_stress = (1 - materials.lower.poisson_ratio**2) / materials.lower.young_modulus
    upper_strain_per_stress = (1 - materials.upper.poisson_ratio**2) / materials.upper.young_modulus
    return lower_strain_per_stress, -upper_strain_per_stress


def one_curve(scene: Scene, path: LoadPath | None = None) -> OneCurve | None:
    """Contact and loads of a path with bulk strain eps and tilt alpha whose frictional state is one
    memory curve. None where it takes more than one curve.

    A memory curve is the tangential force, or the bulk strain, locked in up to each normal load.

    One curve is enough where alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q with one kappa,
    and contact intervals are nested. At constant P large bulk strain has one curve as well, and so
    has bulk strain alone, as long as the stick zones recede at both ends.

    While P is applied at first, with no Q and no change of bulk strain, the tilt may vary freely:
    nothing is sheared, and nothing is locked in.

    Parameters
    ----------
    scene
        profile, material, friction and load path
    path
        load path to take in place of that of the scene; None: that of the scene

    Raises
    ------
    InputError
        For a profile that bends down somewhere, a contact that leaves the profile, a tilt or a
        moment that no contact carries.
    """
    path = path or scene.load.path()
    gap = convex_profile(scene.profile)
    friction_coefficient = scene.friction.coefficient
    # (4, n) P, Q, eps and alpha along the path from where it first shears the contact
    sampled_path = _SampledPath.of_path(path, scene)
    samples = sampled_path.samples
    # Q shears the contact; or bulk strain alone, and then a load in proportion to it replaces Q
    shearing = _ShearOfCurve.of_samples(samples, gap, friction_coefficient, sampled_path.load_sizes)

    # alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q, and whether they hold
    affine_relation = _AffineRelation.fitted_to_samples(
        samples, shearing.load_in_curve, sampled_path.load_sizes
    )
    if not affine_relation.holds:
        return None

    largest_load = float(np.max(samples[0]))
    intervals = NestedIntervals(
        gap,
        2 / composite_modulus(scene.material),  # A = 2/E*
        affine_relation.tilt_without_load,
        affine_relation.kappa,
        largest_load,
    )
    contact = _contact_with_one_curve(
        intervals, scene.profile.datum_length, friction_coefficient, shearing
    )
    if contact is None:
        return None
    path_of_curve = _path_of_curve(
        path,
        sampled_path.first_shearing_segment if shearing.is_strain_alone else None,
        strain_per_stress_of(scene.material),
        shearing.first_strain,
        affine_relation.kappa,
    )
    if path_of_curve is None:
        return None
    # `companion`: bulk stresses, or tilt and moment, over the time of the path
    return OneCurve(
        contact=contact,
        path=path_of_curve,
        bulk=path.companion("bulk"),
        tilt_and_moment=path.companion("tilt_and_moment"),
        moment_is_given=path.moment_is_given,
        neglected_loads=shearing.neglected_loads | affine_relation.neglected_loads,
    )


class _SampledPath(NamedTuple):
    """Samples of P, Q, bulk strain and tilt along a load path, from where it first shears the
    contact.

    Before that it only presses, which leaves nothing locked in.

    Attributes
    ----------
    samples
        (4, n) P, Q [force per thickness], bulk strain and tilt [rad], NaN where the tilt is not
        known; the last state of the path alone where no segment shears
    first_shearing_segment
        number of the first segment that shears, by Q or by a change of bulk strain
    load_sizes
        sizes of Q, strain and tilt along the whole path that count, and those that are round-off
    """

    samples: Array
    first_shearing_segment: int
    load_sizes: LoadSizes

    @classmethod
    def of_path(cls, path: LoadPath, scene: Scene) -> _SampledPath:
        """Samples of a load path under which the profile of a scene is pressed; the path may differ
        from that of the scene.
        """
        samples_of_segments = _samples_of_segments(
            (*path.initial_loading, *path.cycle),
            strain_per_stress_of(scene.material),
            _contact_under_moment(scene, path),
        )
        load_sizes = LoadSizes.of_samples(
            np.concatenate(samples_of_segments, axis=1),
            convex_profile(scene.profile),
            2 / composite_modulus(scene.material),  # A = 2/E*
            scene.friction.coefficient,
        )
        first_shearing_segment = _first_shearing_segment(
            samples_of_segments[: len(path.initial_loading)], load_sizes
        )
        shearing_samples = samples_of_segments[first_shearing_segment:]
        if not shearing_samples:  # the last sample alone
            shearing_samples = [samples_of_segments[-1][:, -1:]]
        return cls(np.concatenate(shearing_samples, axis=1), first_shearing_segment, load_sizes)


class _ShearOfCurve(NamedTuple):
    """What shears a contact along a load path: Q, or bulk strain alone at constant P.

    Attributes
    ----------
    load_in_curve
        (n,) load of the memory curve at samples of the path: Q; where bulk strain alone shears, a
        load in proportion to its change, of half f P at most [force per thickness]
    is_strain_alone
        whether bulk strain alone shears
    first_strain
        bulk strain at the first sample, where the load in proportion to its change is 0
    may_slip_opposite_ways
        whether the profile is a parabola, f > 0 and P constant: under large bulk strain both ends
        of such a contact slip in opposite senses, and its stick zones are nested where contacts are
        not
    neglected_loads
        "tangential load": the largest |Q| over f P, where it is round-off beside the bulk strain;
        else empty
    """

    load_in_curve: Array
    is_strain_alone: bool
    first_strain: float
    may_slip_opposite_ways: bool
    neglected_loads: dict[str, float]

    @classmethod
    def of_samples(
        cls, samples: Array, profile: ConvexProfile, friction: float, load_sizes: LoadSizes
    ) -> _ShearOfCurve:
        """What shears a contact along its load path: Q, or bulk strain alone at constant P.

        Parameters
        ----------
        samples
            (4, n) P, Q, bulk strain eps and tilt along the path
        profile
            the gap; `radius` of a parabola, None of another one
        friction
            f
        load_sizes
            round-off of Q and of eps: a change up to it counts as none

        # notation: p, q, eps samples (n,) of P, Q and bulk strain
        """
        p, q, eps, _ = samples
        largest_load = float(np.max(p))
        is_parabola = profile.radius is not None
        has_constant_load = np.ptp(p) <= _ROUND_OFF_SHARE * largest_load
        may_slip_opposite_ways = bool(is_parabola and friction > 0 and has_constant_load)
        strain_changes = np.ptp(eps) > load_sizes.strain_roundoff
        has_shear_force = np.max(np.abs(q)) > load_sizes.shear_roundoff
        is_strain_alone = bool(may_slip_opposite_ways and strain_changes and not has_shear_force)
        first_strain = float(eps[0])
        load_in_curve = q
        neglected_loads = {}
        if is_strain_alone:
            if np.any(q):
                neglected_loads["tangential load"] = float(np.max(np.abs(q))) / (
                    friction * largest_load
                )
            # a load in proportion to the change of strain, of half f P at most
            largest_change = float(np.max(np.abs(eps - first_strain)))
            load_in_curve = (eps - first_strain) * (friction * largest_load / 2 / largest_change)
        return cls(
            load_in_curve, is_strain_alone, first_strain, may_slip_opposite_ways, neglected_loads
        )


def _path_of_curve(
    path: LoadPath,
    first_segment_by_strain: int | None,
    strain_per_stress: tuple[float, float],
    strain_without_load: float,
    strain_per_load: float,
) -> LoadPath | None:
    """Load path of a memory curve: P and Q alone, without bulk stress and tilt. From a certain
    segment on a load in proportion to the bulk strain eps may replace Q.

    None where a load replaces Q while bulk stress is neither linear nor a sum of harmonics in
    time.

    Parameters
    ----------
    path
        load path with bulk stress and tilt: initial loading and cycle
    first_segment_by_strain
        number of the first segment in which that load replaces Q; None where Q is kept in all
    strain_per_stress
        eps by a unit bulk stress of the lower and of the upper body [1/stress]
    strain_without_load
        eps at which that load is 0
    strain_per_load
        slope of eps over the load that replaces Q
    """
    segments = (*path.initial_loading, *path.cycle)
    n_segments_with_q = len(segments)
    if first_segment_by_strain is not None:
        n_segments_with_q = first_segment_by_strain
    segments_of_curve: list[LoadSegment] = [
        replace(segment, bulk=None, tilt_and_moment=None)
        for segment in segments[:n_segments_with_q]
    ]
    for segment in segments[n_segments_with_q:]:
        segment_of_curve = _segment_with_strain_for_shear(
            segment, strain_per_stress, strain_without_load, strain_per_load
        )
        if segment_of_curve is None:
            return None
        segments_of_curve.append(segment_of_curve)
    n_loading_segments = len(path.initial_loading)
    return LoadPath(
        tuple(segments_of_curve[:n_loading_segments]), tuple(segments_of_curve[n_loading_segments:])
    )


def _contact_under_moment(scene: Scene, path: LoadPath) -> TiltedProfile | None:
    """Contact of a scene that gives the tilt under a load and a moment; None where the load path
    prescribes the tilt in place of the moment.
    """
    if not path.moment_is_given:
        return None
    intervals = NestedIntervals(
        convex_profile(scene.profile),
        2 / composite_modulus(scene.material),  # A = 2/E*
        tilt_without_load=0.0,
        tilt_per_load=0.0,
        largest_load=math.inf,
    )
    return TiltedProfile(intervals, scene.profile.datum_length)


def _contact_with_one_curve(
    intervals: NestedIntervals, datum_length: float, friction: float, shearing: _ShearOfCurve
) -> TiltedProfile | None:
    """The contact whose frictional state is one memory curve: that of nested contact intervals, or
    a parabola whose two ends slip in opposite senses; None where neither exists.

    A memory curve is the tangential force, or the bulk strain, locked in up to each normal load.
    Intervals are nested where each lies within those of all larger loads.

    Parameters
    ----------
    intervals
        contact intervals under the loads of the path, up to its largest P
    datum_length
        distance at which displacements count as 0 [length]
    friction
        f, coefficient of friction
    shearing
        what shears the contact, Q or bulk strain alone (`is_strain_alone`); whether its ends may
        slip opposite ways; Q along the path, or the load that replaces it (`load_in_curve`)
    """
    contact = TiltedProfile(intervals, datum_length)
    if not shearing.is_strain_alone and contact.is_nested(intervals.largest_load):
        return contact
    if not shearing.may_slip_opposite_ways:
        return None
    largest_shear = float(np.max(np.abs(shearing.load_in_curve)))
    return _opposite_slip_contact(
        intervals, datum_length, friction, largest_shear, shearing.is_strain_alone
    )


def _first_shearing_segment(samples_of_loading: list[Array], load_sizes: LoadSizes) -> int:
    """Number of the first segment of the initial loading that shears the contact, by Q or by a
    change of bulk strain; the number of segments where none does.

    `samples_of_loading` are P, Q, bulk strain eps and tilt alpha of each segment, (4, n).
    `load_sizes` holds the sizes up to which Q and a change of strain are round-off.
    """
    for segment_number, samples in enumerate(samples_of_loading):
        if not _presses_only(samples, load_sizes):
            return segment_number
    return len(samples_of_loading)


class _AffineRelation(NamedTuple):
    """alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q with one kappa, fitted to samples of a
    load path, and whether they hold.

    Attributes
    ----------
    kappa, tilt_without_load
        slope [1/(force per thickness)] of both lines, alpha_0 [rad]
    holds
        whether strain and tilt of all samples are on the lines to round-off
    neglected_loads
        "bulk stress" and "tilt": largest deviations from the lines, each over the strain or tilt
        that makes an edge of contact slip or lift. One within the round-off of strain or tilt
        itself has no entry
    """

    kappa: float
    tilt_without_load: float
    holds: bool
    neglected_loads: dict[str, float]

    @classmethod
    def fitted_to_samples(
        cls, samples: Array, load_in_curve: Array, load_sizes: LoadSizes
    ) -> _AffineRelation:
        """The lines alpha = alpha_0 + kappa P and eps = eps_0 + kappa Q with one kappa, fitted to n
        samples of a load path, and whether both hold to round-off.

        kappa is that of eps over Q where Q changes, else of alpha over P. A deviation from the
        lines may be round-off beside the strain or tilt that moves an edge of contact, and yet be
        above the round-off of the strain or tilt itself: then it is stated as neglected.

        Parameters
        ----------
        samples
            (4, n) P, Q, bulk strain eps of the lower surface relative to the upper one, and tilt
            alpha [rad], NaN where it is not known; Q is not used
        load_in_curve
            (n,) Q, or the load that replaces it [force per thickness]
        load_sizes
            `..._roundoff`: size below which a change of shear, strain or tilt is round-off;
            `slipping_strain` makes an edge of contact slip, `lifting_tilt` makes it lift
        """
        normal_load, _, eps, alpha = samples
        is_tilt_known = np.isfinite(alpha)
        load_at_known_tilt = normal_load[is_tilt_known]
        known_tilt = alpha[is_tilt_known]
        # Changes of strain or tilt below their round-off count as none.
        if np.ptp(load_in_curve) > load_sizes.shear_roundoff:
            kappa = _least_squares_slope(load_in_curve, eps, load_sizes.strain_roundoff)
        else:
            kappa = _least_squares_slope(load_at_known_tilt, known_tilt, load_sizes.tilt_roundoff)
        tilt_without_load = 0.0
        if np.any(is_tilt_known):
            tilt_without_load = float(np.mean(known_tilt - kappa * load_at_known_tilt))

        # Largest deviations from both lines, and what round-off allows.
        strain_deviation = float(np.ptp(eps - kappa * load_in_curve))
        tilt_deviations = np.abs(known_tilt - tilt_without_load - kappa * load_at_known_tilt)
        tilt_deviation = float(np.max(tilt_deviations, initial=0.0))
        largest_shear = np.max(np.abs(load_in_curve))
        largest_load = np.max(normal_load)
        allowed_strain_deviation = (
            load_sizes.strain_roundoff + _ROUND_OFF_SHARE * abs(kappa) * largest_shear
        )
        allowed_tilt_deviation = (
            load_sizes.tilt_roundoff + _ROUND_OFF_SHARE * abs(kappa) * largest_load
        )
        holds = not (
            strain_deviation > allowed_strain_deviation or tilt_deviation > allowed_tilt_deviation
        )
        neglected_loads = {}
        if holds:
            if strain_deviation > _ROUND_OFF_SHARE * np.max(np.abs(eps)):
                neglected_loads["bulk stress"] = strain_deviation / load_sizes.slipping_strain
            if tilt_deviation > _ROUND_OFF_SHARE * np.max(np.abs(known_tilt)):
                neglected_loads["tilt"] = tilt_deviation / load_sizes.lifting_tilt
        return cls(kappa, tilt_without_load, holds, neglected_loads)


def _opposite_slip_contact(
    intervals: NestedIntervals,
    datum_length: float,
    friction: float,
    largest_shear: float,
    is_strain_alone: bool,
) -> OppositeSlip | None:
    """The contact of a parabola at constant P whose two ends slip in opposite senses under large
    bulk strain (Nowell and Hills 1987), or None.

    Its stick zones must be nested, each within those of all smaller |Q|, up to the largest |Q| of
    the path. None where they are not, or where they cannot be resolved numerically.

    Parameters
    ----------
    intervals
        contact intervals of the parabola, up to the largest P of the path
    datum_length
        distance at which displacements count as 0 [length]
    friction
        f, coefficient of friction
    largest_shear
        the largest |Q|, or of the load in its place [force per thickness]
    is_strain_alone
        whether Q = 0, and a load in proportion to the bulk strain replaces it
    """
    contact = OppositeSlip(
        intervals,
        datum_length,
        friction=friction,
        largest_tangential_load=largest_shear,
        tangential_fraction=0.0 if is_strain_alone else 1.0,
    )
    # is_nested: whether stick zones, and contacts, lie within one another up to the largest load.
    try:
        return contact if contact.is_nested(intervals.largest_load) else None
    except (ArithmeticError, UnresolvedError):
        return None


@dataclass(frozen=True)
class LoadSizes:
    """Sizes of bulk strain, tilt and Q along a load path that count, and those that are round-off;
    a is the half-width at its largest load P, A = 2/E*.

    Attributes
    ----------
    slipping_strain, lifting_tilt
        A f P/(pi a) and A P/(pi a): of the order of what makes a whole edge of contact slip, or
        lift
    strain_roundoff, tilt_roundoff, shear_roundoff
        below it a change of bulk strain, tilt and Q changes no digit
    """

    slipping_strain: float
    lifting_tilt: float
    strain_roundoff: float
    tilt_roundoff: float
    shear_roundoff: float

    @property
    def roundoff(self) -> Array:
        """Round-off of P, Q, eps and alpha, (4,)."""
        return np.array(
            [self.shear_roundoff, self.shear_roundoff, self.strain_roundoff, self.tilt_roundoff]
        )

    @classmethod
    def of_samples(
        cls, samples: Array, profile: ConvexProfile, compliance: float, friction: float
    ) -> LoadSizes:
        """Bulk strain that makes an edge of contact slip and tilt that lifts it, at the largest P
        of a load path, and the round-off of strain, tilt and Q.

        Round-off is 1e-11 of the largest value of each, or of what makes an edge slip or lift (of
        f P for Q) if that is larger.

        Parameters
        ----------
        samples
            (4, n) P, Q, bulk strain and tilt along the path, NaN where the tilt is not known
        profile
            the gap h(x)
        compliance, friction
            A = 2/E*; f

        # notation: p, q, eps, alpha samples (n,) of P, Q, bulk strain and tilt
        """
        p, q, eps, alpha = samples
        is_tilt_known = np.isfinite(alpha)
        sample_of_largest_load = int(np.argmax(p))
        largest_load = float(p[sample_of_largest_load])
        tilt_at_largest_load = (
            alpha[sample_of_largest_load] if is_tilt_known[sample_of_largest_load] else 0.0
        )
        _, contact_half_width = profile.contact_centre_and_half_width(
            compliance * largest_load, tilt_at_largest_load
        )
        half_width = float(contact_half_width)
        # A P/(pi a) lifts an edge, f times it makes it slip.
        lifting_tilt = 0.0
        if half_width > 0:
            lifting_tilt = compliance * largest_load / (math.pi * half_width)
        slipping_strain = friction * lifting_tilt
        largest_strain = float(np.max(np.abs(eps)))
        largest_tilt = float(np.max(np.abs(alpha), where=is_tilt_known, initial=0.0))
        largest_shear = float(np.max(np.abs(q)))
        return cls(
            slipping_strain=slipping_strain,
            lifting_tilt=lifting_tilt,
            strain_roundoff=_ROUND_OFF_SHARE * max(largest_strain, slipping_strain),
            tilt_roundoff=_ROUND_OFF_SHARE * max(largest_tilt, lifting_tilt),
            shear_roundoff=_ROUND_OFF_SHARE * max(largest_shear, friction * largest_load),
        )


def cycle_samples(scene: Scene) -> Array:
    """P, Q [force per thickness], bulk strain and tilt [rad] at instants of a scene's cycle, rows
    of (4, n), in order of time. All turning points are among the instants.

    A tilt that is not prescribed follows from the moment.
    """
    path = scene.load.path()
    samples_of_segments = _samples_of_segments(
        path.cycle, strain_per_stress_of(scene.material), _contact_under_moment(scene, path)
    )
    return np.concatenate(samples_of_segments, axis=1)


def steady_curve(scene: Scene) -> OneCurve | None:
    """Contact and loads of a scene's cycle, reached by another initial loading, where its
    frictional state is one memory curve; None where it is not, or without a cycle.

    A memory curve is the tangential force, or the bulk strain, locked in up to each normal load.
    The other initial loading presses to the first P of the cycle, then shears to its first Q. What
    changes in a steady cycle of like bodies does not depend on how it was reached, and so neither
    the friction work W nor W(x) depends on it (Andersson, Barber and Ponter, 2014). The traction
    locked in the permanent stick zone depends on it. W(x) is the friction work per area.
    """
    path = scene.load.path()
    if not path.cycle:
        return None
    # bulk strain by a unit of bulk stress in the lower and in the upper body
    strain_per_stress = strain_per_stress_of(scene.material)
    # Q and bulk strain over the cycle, and their line
    _, tangential_loads, bulk_strains = _samples_without_tilt(path.cycle, strain_per_stress)
    strain_per_load = _least_squares_slope(tangential_loads, bulk_strains)
    loading = _pressing_then_shearing(path, strain_per_load, strain_per_stress[0])
    return one_curve(scene, LoadPath(loading, path.cycle, path.moment_is_given))


def _pressing_then_shearing(
    path: LoadPath, strain_per_load: float, strain_per_lower_stress: float
) -> tuple[StraightSegment, StraightSegment]:
    """Initial loading that presses to the first P of a path's cycle without Q, then shears to its
    first Q at constant P.

    Both segments are straight, each over half of the time before the cycle. Tilt or moment grows
    with P, and is constant while Q grows. Bulk stress is constant while P grows. Then that of the
    lower body grows to its first value in the cycle.

    Parameters
    ----------
    path
        load path, with bulk stresses (`bulk`), tilt and moment of its segments, None without any
    strain_per_load
        slope of the line of bulk strain over Q in the cycle [1/(force per thickness)]
    strain_per_lower_stress
        bulk strain by a unit of bulk stress in the lower body [1/stress]
    """
    path_start = path.start
    cycle_start = path.cycle_start
    middle_time = (path_start + cycle_start) / 2
    first_of_cycle = path.cycle[0]
    normal_load, tangential_load = map(float, first_of_cycle.loads(cycle_start))
    pressing_segment = StraightSegment(path_start, middle_time, (0.0, 0.0), (normal_load, 0.0))
    shearing_segment = StraightSegment(
        middle_time, cycle_start, (normal_load, 0.0), (normal_load, tangential_load)
    )
    if first_of_cycle.bulk is not None:
        # While P alone grows, bulk strain has the value of Q = 0 on its line over Q in the cycle.
        # The bulk stress of the lower body is set for that; that of the upper body is constant.
        lower_stress, upper_stress = map(float, first_of_cycle.bulk.loads(cycle_start))
        lower_stress_before = (
            lower_stress - strain_per_load * tangential_load / strain_per_lower_stress
        )
        stresses_before = (lower_stress_before, upper_stress)
        pressing_segment = replace(
            pressing_segment,
            bulk=StraightSegment(path_start, middle_time, stresses_before, stresses_before),
        )
        shearing_segment = replace(
            shearing_segment,
            bulk=StraightSegment(
                middle_time, cycle_start, stresses_before, (lower_stress, upper_stress)
            ),
        )
    if first_of_cycle.tilt_and_moment is not None:
        tilt, moment = map(float, first_of_cycle.tilt_and_moment.loads(cycle_start))
        pressing_segment = replace(
            pressing_segment,
            tilt_and_moment=StraightSegment(path_start, middle_time, (0.0, 0.0), (tilt, moment)),
        )
        shearing_segment = replace(
            shearing_segment,
            tilt_and_moment=StraightSegment(
                middle_time, cycle_start, (tilt, moment), (tilt, moment)
            ),
        )
    return pressing_segment, shearing_segment


def _segment_with_strain_for_shear(
    segment: LoadSegment,
    strain_per_stress: tuple[float, float],
    strain_without_load: float,
    strain_per_load: float,
) -> LoadSegment | None:
    """A segment of a load path at constant P in which Q is replaced by a load in proportion to the
    bulk strain eps, (eps - strain_without_load)/strain_per_load [force per thickness].

    None where bulk stress is neither linear nor a sum of harmonics in time.

    Parameters
    ----------
    segment
        the segment of the path, with its bulk stresses as `bulk` (None without any)
    strain_per_stress
        bulk strain eps by a unit bulk stress of the lower and of the upper body [1/stress]
    strain_without_load
        eps at which that load is 0
    strain_per_load
        slope of eps over the load that replaces Q
    """

    def load_of(stresses: Sequence[float]) -> float:
        """Load that replaces Q, under given bulk stresses of the lower and the upper body."""
        return (float(np.dot(strain_per_stress, stresses)) - strain_without_load) / strain_per_load

    normal_load = float(segment.loads(segment.start)[0])
    bulk = segment.bulk
    if bulk is None:
        constant_load = load_of((0.0, 0.0))
        return StraightSegment(
            segment.start, segment.end, (normal_load, constant_load), (normal_load, constant_load)
        )

    # Linear in time.
    if bulk.is_straight:
        first_load = load_of([float(stress) for stress in bulk.loads(segment.start)])
        last_load = load_of([float(stress) for stress in bulk.loads(segment.end)])
        return StraightSegment(
            segment.start, segment.end, (normal_load, first_load), (normal_load, last_load)
        )
    if not isinstance(bulk, HarmonicSegment):
        return None

    # constant P; mean and harmonics of the load that replaces Q
    return HarmonicSegment(
        segment.start,
        segment.end,
        (normal_load, load_of(bulk.mean)),
        (),
        _harmonics_of_strain(bulk, strain_per_stress, strain_per_load),
    )


def _harmonics_of_strain(
    bulk: HarmonicSegment, strain_per_stress: tuple[float, float], strain_per_load: float
) -> tuple[tuple[float, float], ...]:
    """Amplitude [force per thickness] and phase [rad] of each harmonic of the load that replaces
    Q, in proportion to the bulk strain: the strain over `strain_per_load`.

    `bulk` stores the bulk stress of the lower body where other segments have P, that of the upper
    body where they have Q. `strain_per_stress` is the bulk strain by a unit of each [1/stress].
    """
    harmonics_of_bodies = (bulk.normal, bulk.tangential)
    # complex amplitudes of the harmonics of both bodies
    phasors = np.zeros((2, max(map(len, harmonics_of_bodies))), dtype=complex)
    for phasors_of_body, harmonics in zip(phasors, harmonics_of_bodies, strict=True):
        phasors_of_body[: len(harmonics)] = [
            amplitude * cmath.exp(-1j * phase) for amplitude, phase in harmonics
        ]
    load_phasors = (np.array(strain_per_stress) @ phasors / strain_per_load).tolist()
    return tuple((abs(phasor), -cmath.phase(phasor)) for phasor in load_phasors)


class Eccentricity(NamedTuple):
    """How far bulk strain moves the stick zone, and whether that strain is moderate.

    Attributes
    ----------
    value
        e = eps R/(f a) of a parabola, with a the contact half-width at the largest P. At constant P
        and in phase the centre of the stick zone moves by e a. NaN of other profiles and without
        friction
    strain
        eps, half the range of the bulk strain in the cycle
    limit
        the largest moderate eps: A Q/(pi a), with half the range of Q. Up to it, in phase and at
        constant P, both ends of contact slip one way
    """

    value: float
    strain: float
    limit: float

    @property
    def moderate(self) -> bool:
        """Whether eps is not above its limit."""
        return self.strain <= self.limit * (1 + _ROUND_OFF_SHARE)


def eccentricity(scene: Scene) -> Eccentricity | None:
    """Eccentricity e of the stick zone under bulk stress, the distance of its middle from that of
    the contact over the half-width a; the amplitude of bulk strain that causes it, and the largest
    amplitude that is moderate. None without bulk stress.

    Bulk stress is moderate if both ends of the contact slip the same way, as they do under Q alone.
    The limit is that of loads in phase at constant P. With P, Q or bulk stress out of phase the
    ends may slip opposite ways below it.

    e = eps R/(f a) of a parabola of radius R, NaN of other profiles and without friction. eps is
    half the range of bulk strain in the cycle, or along a path without one. a is that of the
    largest P without tilt. With bulk stress sigma in one of two like bodies, e = sigma/(4 f p0), p0
    the largest pressure (Nowell and Hills 1987).

    Returns
    -------
    Eccentricity | None
        e, the amplitude eps, and the largest moderate amplitude, (A/(pi a)) Q with half the range
        of Q and A = 2/E*

    >>> from scenes import load_scene
    >>> scene = load_scene("cattaneo-mindlin")
    >>> eccentricity(scene) is None
    True
    """
    scene = validated(scene, Scene)
    path = scene.load.path()
    profile = scene.profile
    friction_coefficient = scene.friction.coefficient
    segments = path.cycle or path.initial_loading
    if not path.has_bulk_or_tilt or all(segment.bulk is None for segment in segments):
        return None

    # samples (n,) of P, Q and bulk strain eps
    normal_loads, tangential_loads, bulk_strains = _samples_without_tilt(
        segments, strain_per_stress_of(scene.material)
    )
    half_width = _half_width_without_tilt(scene, float(np.max(normal_loads)))
    strain_amplitude = float(np.ptp(bulk_strains)) / 2
    shear_amplitude = float(np.ptp(tangential_loads)) / 2
    stick_eccentricity = math.nan
    if isinstance(profile, Hertz) and friction_coefficient > 0:
        stick_eccentricity = strain_amplitude * profile.radius / (friction_coefficient * half_width)
    modulus = composite_modulus(scene.material)  # E*
    largest_moderate_strain = 2 * shear_amplitude / (math.pi * modulus * half_width)
    return Eccentricity(stick_eccentricity, strain_amplitude, largest_moderate_strain)


def _half_width_without_tilt(scene: Scene, normal_load: float) -> float:
    """Half-width of the contact of a scene's profile, symmetric or any convex one, under the load P
    without tilt [length].
    """
    profile = scene.profile
    if profile.symmetric:
        return float(contact_of(profile, scene.material).half_width(normal_load))
    compliance = 2 / composite_modulus(scene.material)  # A = 2/E*
    _, half_width = convex_profile(profile).contact_centre_and_half_width(
        compliance * normal_load, 0.0
    )
    return float(half_width)


def followed_path(scene: Scene) -> LoadPath:
    """Load path of P and Q alone of a scene whose frictional state is one memory curve, the
    tangential force locked in up to each normal load.

    It is the scene's path without bulk stress and tilt, which only move the contact intervals.

    Raises
    ------
    InputError
        For a path with bulk stress or tilt that has no single curve, a profile that bends down
        somewhere, a contact that leaves the profile.
    """
    scene_path = scene.load.path()
    if not scene_path.has_bulk_or_tilt:
        return scene_path
    # None where more than one memory curve is needed.
    curve = one_curve(scene)
    # Where bulk strain alone shears, the curve is not one of Q: its `tangential_fraction` is 0.
    if curve is None or not curve.contact.tangential_fraction:
        raise InputError(REASON_WITHOUT_ONE_CURVE)
    return curve.path


@dataclass(frozen=True, eq=False)
class PathLoads:
    """P, Q, bulk strain eps and tilt alpha of a load path over time, the first cycle and its
    repetitions.

    Attributes
    ----------
    path
        the load path
    strain_per_stress
        eps by a unit bulk stress of the lower and of the upper body [1/stress]
    contact
        the profile, for the tilt under a given moment
    """

    path: LoadPath
    strain_per_stress: tuple[float, float]
    contact: TiltedProfile

    def _segment_at(self, time: float) -> tuple[LoadSegment, float]:
        """Segment of the load path at a time, and the duration of all cycles completed before it.
        By that duration the time is later than the same instant of the first cycle.

        The path has an initial loading, then a cycle that repeats with `period`, None if it does
        not. A time after the end of a path is in its last segment.
        """
        path = self.path
        duration_of_earlier_cycles = 0.0
        if path.period is not None and time > path.cycle_start:
            duration_of_earlier_cycles = (
                math.floor((time - path.cycle_start) / path.period) * path.period
            )
        segments = (*path.initial_loading, *path.cycle)
        time_in_path = time - duration_of_earlier_cycles
        for segment in segments:
            if time_in_path <= segment.end:
                return segment, duration_of_earlier_cycles
        return segments[-1], duration_of_earlier_cycles

    def loads_in_segment(self, time: Array) -> Array:
        """P, Q [force per thickness], bulk strain eps and tilt alpha [rad] at times (n,) within one
        segment of the load path, as rows of (4, n).

        eps is by how much the bulk stresses stretch the lower surface more than the upper one. A
        tilt that is not prescribed follows from the moment.
        """
        # All cycles are like the first: times go back to it by the duration of those before.
        segment, duration_of_earlier_cycles = self._segment_at(float(np.mean(time)))
        time_in_path = time - duration_of_earlier_cycles
        p, q = segment.loads(time_in_path)
        stress_of_lower_body, stress_of_upper_body = _companion_loads(segment.bulk, time_in_path)
        tilt, moment = _companion_loads(segment.tilt_and_moment, time_in_path)
        lower_strain_per_stress, upper_strain_per_stress = self.strain_per_stress
        eps = (
            lower_strain_per_stress * stress_of_lower_body
            + upper_strain_per_stress * stress_of_upper_body
        )
        p, q, eps, tilt, moment, _ = np.broadcast_arrays(p, q, eps, tilt, moment, time)
        if self.path.moment_is_given:
            tilt = self.contact.tilt_under(p, moment)
        return np.stack([p, q, eps, tilt])

    def loads_at(self, time: Array) -> Array:
        """P, Q [force per thickness], bulk strain eps and tilt alpha [rad] at any times (n,), as
        rows of (4, n).

        A time before the path counts as its start, one after a path without cycles as its end.
        """
        path = self.path
        path_end = math.inf if path.period is not None else path.initial_loading[-1].end
        times_in_path = np.clip(time, path.start, path_end)
        loads = np.empty((4, len(times_in_path)))
        for instant_numbers in self._instants_by_segment(times_in_path):
            loads[:, instant_numbers] = self.loads_in_segment(times_in_path[instant_numbers])
        return loads

    def bulk_stresses(self, time: Array) -> Array:
        """Bulk stress of the lower and of the upper body [stress], (2, n), for any times (n,)."""
        stresses = np.zeros((2, len(time)))
        for instant_numbers in self._instants_by_segment(time):
            times_in_segment = time[instant_numbers]
            # Times of a segment are those of the first cycle.
            segment, duration_of_earlier_cycles = self._segment_at(float(times_in_segment[0]))
            stresses[:, instant_numbers] = _companion_loads(
                segment.bulk, times_in_segment - duration_of_earlier_cycles
            )
        return stresses

    def _instants_by_segment(self, time: Array) -> list[list[int]]:
        """Numbers of the times (n,) that lie in one segment of the load path and in one cycle, a
        list for each such segment.
        """
        numbers_by_segment: dict[tuple[int, float], list[int]] = {}
        for instant_number, instant in enumerate(time.tolist()):
            segment, duration_of_earlier_cycles = self._segment_at(instant)
            key_of_segment = (id(segment), duration_of_earlier_cycles)
            numbers_by_segment.setdefault(key_of_segment, []).append(instant_number)
        return list(numbers_by_segment.values())

    def turning_times(self, segment: LoadSegment) -> list[float]:
        """Times in a segment of the load path at which P, Q, bulk strain, tilt or moment turn, and
        the end of the segment. Of times within 1e-6 of the duration of the segment one is given.
        """
        # `turning_points`: times at which a weighted sum of the two loads of a segment turns.
        # NORMAL_LOAD, TANGENTIAL_LOAD: its first and its second load alone.
        turning_times = segment.turning_points(NORMAL_LOAD)
        turning_times += segment.turning_points(TANGENTIAL_LOAD)
        if segment.bulk is not None:
            # bulk strain: the stresses of lower and upper body, each times its strain per stress
            turning_times += segment.bulk.turning_points(Combination(*self.strain_per_stress))
        tilt_and_moment = segment.tilt_and_moment
        if tilt_and_moment is not None:
            turning_times += tilt_and_moment.turning_points(NORMAL_LOAD)
            turning_times += tilt_and_moment.turning_points(TANGENTIAL_LOAD)
        different_times = [segment.end]
        for time in turning_times:
            time_to_nearest = min(abs(time - known_time) for known_time in different_times)
            if time_to_nearest > 1e-6 * (segment.end - segment.start):
                different_times.append(time)
        return different_times


def _presses_only(samples: Array, load_sizes: LoadSizes) -> bool:
    """Whether samples (4, n) of a segment have no Q and no change of bulk strain, to round-off."""
    _, q, eps, _ = samples
    return bool(
        np.max(np.abs(q)) <= load_sizes.shear_roundoff and np.ptp(eps) <= load_sizes.strain_roundoff
    )


def _samples_of_segments(
    segments: Sequence[LoadSegment],
    strain_per_stress: tuple[float, float],
    contact_under_moment: TiltedProfile | None,
) -> list[Array]:
    """P, Q [force per thickness], bulk strain and tilt [rad] at instants of each segment of a load
    path, (4, n) each; all turning points are among the instants.

    `strain_per_stress` is the bulk strain by a unit of bulk stress in the lower and in the upper
    body [1/stress]. `contact_under_moment` gives the tilt where the path prescribes the moment;
    None where it prescribes the tilt.
    """
    return [
        _load_samples_of_segment(segment, contact_under_moment, strain_per_stress)
        for segment in segments
    ]


def _samples_without_tilt(
    segments: Sequence[LoadSegment], strain_per_stress: tuple[float, float]
) -> Array:
    """P, Q [force per thickness] and bulk strain at instants of all segments of a load path, rows
    of (3, n), in order of time; tilt and moment are ignored.

    Turning points are among the instants. `strain_per_stress` is the bulk strain by a unit of bulk
    stress in the lower and in the upper body [1/stress].
    """
    segments_without_tilt = [replace(segment, tilt_and_moment=None) for segment in segments]
    samples = _samples_of_segments(segments_without_tilt, strain_per_stress, None)
    return np.asarray(np.concatenate(samples, axis=1)[:3])


def _load_samples_of_segment(
    segment: LoadSegment,
    contact_under_moment: TiltedProfile | None,
    strain_per_stress: tuple[float, float],
) -> Array:
    """P, Q [force per thickness], bulk strain eps and tilt alpha [rad] at ascending instants of a
    segment of the load path, (4, n). With turning points they are enough to test relations between
    the loads.

    Parameters
    ----------
    segment
        segment of P and Q, with those of bulk stresses, `bulk`, and of tilt and moment, None each
        without any
    contact_under_moment
        gives the tilt where the moment is prescribed: NaN under a moment at P = 0; None where the
        tilt is prescribed
    strain_per_stress
        eps by a unit bulk stress of the lower and of the upper body [1/stress]

    # notation: p, q values of P and Q
    """
    time = _times_of_samples(segment, strain_per_stress)
    # Loads at these times; tilt and moment, one of them prescribed; bulk stresses of both bodies.
    p, q = segment.loads(time)
    stress_of_lower_body, stress_of_upper_body = _companion_loads(segment.bulk, time)
    tilt, moment = _companion_loads(segment.tilt_and_moment, time)
    if contact_under_moment is not None and np.any(moment):
        tilt_by_moment = contact_under_moment.tilt_under(*np.broadcast_arrays(p, moment))
        tilt = np.where(p > 0, tilt_by_moment, np.nan)
    lower_strain_per_stress, upper_strain_per_stress = strain_per_stress
    eps = (
        lower_strain_per_stress * stress_of_lower_body
        + upper_strain_per_stress * stress_of_upper_body
    )
    return np.stack([p, q, eps, tilt])


def _times_of_samples(segment: LoadSegment, strain_per_stress: tuple[float, float]) -> Array:
    """Ascending times (n,) in a segment of the load path at which its loads are sampled. They are
    both ends and the middle of a straight segment, 40 and more times of a curved one.

    Turning points of P, Q and bulk strain are among them, so that the extreme loads and strains are
    sampled. The segment is straight if its bulk stresses, `bulk`, and its tilt and moment are, too.
    `strain_per_stress` is the bulk strain by a unit bulk stress of the lower and of the upper body
    [1/stress].
    """
    pairs_of_loads = [
        pair for pair in (segment, segment.bulk, segment.tilt_and_moment) if pair is not None
    ]
    n_times = 3
    if not all(pair.is_straight for pair in pairs_of_loads):
        most_turning_points = max(pair.most_turning_points for pair in pairs_of_loads)
        n_times = _INSTANTS_OF_CURVED_SEGMENT + 2 * most_turning_points
    even_times = segment.start + (segment.end - segment.start) * np.linspace(0, 1, n_times)
    # turning_points(c): times at which a weighted sum c of the two loads of a segment turns;
    # NORMAL_LOAD, TANGENTIAL_LOAD: its first and its second load alone
    turning_times = segment.turning_points(NORMAL_LOAD) + segment.turning_points(TANGENTIAL_LOAD)
    if segment.bulk is not None:
        turning_times += segment.bulk.turning_points(Combination(*strain_per_stress))
    return np.unique(np.append(even_times, turning_times))


def _companion_loads(companion: LoadSegment | None, time: Array) -> tuple[Array, Array]:
    """Both loads that a segment has besides P and Q, in the shape of `time`; 0 where it has none.

    They are the bulk stresses of the lower and the upper body, or tilt and moment: `bulk` and
    `tilt_and_moment` of the segment, the `companion`.
    """
    if companion is None:
        return np.zeros(np.shape(time)), np.zeros(np.shape(time))
    first_load, second_load = companion.loads(time)
    zeros = np.zeros(np.shape(time))
    return first_load + zeros, second_load + zeros


def _least_squares_slope(load: Array, values: Array, values_roundoff: float = 0.0) -> float:
    """Least-squares slope of values over a load, (n,) each; 0 where the load is constant to
    round-off, or the values change by no more than their round-off `values_roundoff`.
    """
    if not len(load) or np.ptp(values) <= values_roundoff:
        return 0.0
    if np.ptp(load) <= _ROUND_OFF_SHARE * np.max(np.abs(load)):
        return 0.0
    deviations = load - np.mean(load)
    sum_of_squares = float(deviations @ deviations)
    return float(deviations @ values) / sum_of_squares if sum_of_squares > 0 else 0.0


def path_loads_and_contact(scene: Scene) -> tuple[PathLoads, TiltedProfile]:
    """P, Q, bulk strain and tilt of a scene over time, and the normal contact of its profile as a
    function of load and tilt.

    The contact is defined for normal loads up to the largest P of the path.
    """
    path = scene.load.path()
    largest_load = -math.inf
    # The largest P is at the end of a segment or at a turning point of P within one.
    for segment in (*path.initial_loading, *path.cycle):
        for time in (segment.end, *segment.turning_points(NORMAL_LOAD)):
            normal_load, _ = segment.loads(time)
            largest_load = max(largest_load, float(normal_load))
    # Intervals of contact for tilts that change with the load are not needed: the tilt is given
    # with each load.
    intervals = NestedIntervals(
        convex_profile(scene.profile),
        2 / composite_modulus(scene.material),  # A = 2/E*
        tilt_without_load=0.0,
        tilt_per_load=0.0,
        largest_load=largest_load,
    )
    tilted_contact = TiltedProfile(intervals, scene.profile.datum_length)
    return PathLoads(path, strain_per_stress_of(scene.material), tilted_contact), tilted_contact
