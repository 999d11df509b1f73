"""The coefficient of friction from a measured dissipation: every f at which a cycle of given loads
dissipates W.

# notation: A = 2/E*, W dissipation of a steady cycle, W_inf its limit for f without bound, f_min
least f without gross sliding

At constant P, W falls steadily from f_min on, to 0 as 1/f: one f for each W. Where P varies, W does
not vanish with growing f: a shrinking contact releases energy, which is dissipated at any f. For an
ellipse

    W_inf = (2 A/pi) P1 Q1^2 sin^2(phase) int_0^pi sin^3 t (d ln a/dP) dt,   P = P0 + P1 cos t

since the slip zone of I-J is as thin as 1/f and its shear as large as f. W may therefore have a
least value, and a largest one as well, between f_min and infinity: of 8,000 random ellipses on four
profiles none had more than two, so that a W has up to three f.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import (
    Elastic,
    EllipseLoad,
    InadmissibleLoadError,
    InputError,
    LoadPath,
    Materials,
    Profile,
    Scene,
    read_only_copy,
    sampled_times,
)
from scenes.array_types import Array
from scenes.arrays import real_numbers
from scenes.frozen import validated
from semi_analytic.batches import DissipationBatch, dissipation
from semi_analytic.phases import accepts_phase, phase_in_radians
from semi_analytic.solution import solve

# Samples of W over f. The first are at f_min (1 + 10^k), close to gross sliding, where W has all
# its changes in P_T. Then they are even in ln f up to _MIDDLE_FACTOR times f_min or Q1/P1, the
# larger: by there W has all its turning points. Few are beyond, where W only nears W_inf.
_SAMPLES_CLOSE_TO_SLIDING = 17
_EVEN_SAMPLES = 72
_FAR_SAMPLES = 9
_MIDDLE_FACTOR = 1e2
_LARGEST_FACTOR = 1e6
# The first sample is beyond f_min by its round-off.
_ROUNDOFF_OF_LIMIT = 1e-12
# Fractions of W: a turning point with smaller rises beside it is round-off, and a root with a
# larger residual was not found.
_LEAST_RISE = 1e-10
_LARGEST_RESIDUAL = 1e-8
_LOAD_NAMES = (
    "mean_normal_load",
    "normal_amplitude",
    "mean_tangential_load",
    "tangential_amplitude",
    "phase_radians",
)


class NoFriction(IntEnum):
    """Why no coefficient of friction gives a measured dissipation."""

    NONE = 0
    TOO_LITTLE = 1
    TOO_MUCH = 2
    INVALID = 3
    LOADS = 4
    UNSETTLED = 5


_SENTENCE_OF_REASON = {
    NoFriction.TOO_LITTLE: (
        "W = {target:.6g} is less than these loads dissipate at any f up to {top:.4g}: the least is"
        " {least:.6g}"
    ),
    NoFriction.TOO_MUCH: (
        "W = {target:.6g} is more than these loads dissipate at any f: the most is {most:.6g}, and"
        " they slide grossly below f = {f_min:.6g}"
    ),
    NoFriction.INVALID: (
        "W = {target:.6g} is refused: a measured dissipation is a finite number above 0"
    ),
    NoFriction.LOADS: (
        "no f admits these loads: they are not finite, separate the bodies, leave the profile or"
        " have no Q"
    ),
    NoFriction.UNSETTLED: "W = {target:.6g}: the search for f did not converge",
}


@dataclass(frozen=True, eq=False)
class FrictionBatch:
    """Coefficients of friction at which each member dissipates what was measured; arrays of the
    broadcast shape.

    Attributes
    ----------
    roots
        (..., n) every f, ascending, NaN beyond the last of a member; n is the most that a
        member has, at least 1
    count
        how many f each member has; more than one where P varies and W is no monotone function
        of f
    reason
        `NoFriction` of each member: 0 none, 1 less than the least dissipation at any f, 2 more
        than the largest, 3 a W that is no finite number above 0, 4 loads that no f admits, 5
        the search did not converge
    least_friction
        f_min, below which the contact slides grossly
    least, most
        dissipation at the f that give the least and the most [energy per unit thickness]; these
        and f_min are NaN for loads that no f admits
    sentences
        one for each member without a root, at most ten
    notes
        what holds for all members and must not be missed: the coupling of unlike materials, which
        is neglected
    """

    roots: Array
    count: NDArray[np.int64]
    reason: NDArray[np.int8]
    least_friction: Array
    least: Array
    most: Array
    sentences: tuple[str, ...] = ()
    notes: tuple[str, ...] = field(default=(), kw_only=True)


@accepts_phase
def friction_from(
    dissipation: ArrayLike,
    *,
    scene: Scene | None = None,
    profile: Profile | Mapping[str, Any] | None = None,
    material: Materials | Elastic | None = None,
    mean_normal_load: ArrayLike | None = None,
    normal_amplitude: ArrayLike | None = None,
    tangential_amplitude: ArrayLike | None = None,
    phase_degrees: ArrayLike | None = None,
    phase_radians: ArrayLike | None = None,
    mean_tangential_load: ArrayLike = 0.0,
) -> FrictionBatch:
    """Every coefficient of friction at which the steady cycle dissipates the measured
    `dissipation`.

    Parameters
    ----------
    dissipation
        W of one cycle [energy per unit thickness], > 0, an array that broadcasts with the rest
    scene
        in place of all the others: its profile, material and loads, of any kind; its own
        coefficient of friction is not used
    profile, material
        one profile, or its keys with numbers or arrays; of the two bodies, or one for both
    mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude
        P0, P1, Q0, Q1 of P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase) [force per unit
        thickness]
    phase_degrees, phase_radians
        lag of Q behind P, in degrees or in radians; 90 degrees where neither is given

    Returns
    -------
    FrictionBatch
        with all roots f, arrays of the broadcast shape and one more axis: one, or two or three
        where P varies. W(f) is sampled at 98 coefficients from gross sliding to 10^6 times the
        larger of f_min and Q1/P1; its turning points and roots are then refined. A root is good to
        1e-10 of itself, close to a turning point of W to 1e-5. A member of Hertz takes 0.2 ms, of a
        table 50 ms, a scene whose load is no ellipse seconds.

    Raises
    ------
    InputError
        For a scene beside other arguments, one with bulk stress, tilt or an unsymmetric profile,
        for arguments that are missing, shapes that do not broadcast, and values that are no real
        numbers.

    Examples
    --------
    >>> from scenes import load_scene
    >>> scene = load_scene("hertz-paper")  # f = 1, near the least value of W(f)
    >>> work = solve(scene, x=0.0, fields="dissipation").dissipation
    >>> [round(root, 4) for root in friction_from(work, scene=scene).roots.tolist()]
    [1.0, 1.0411]
    """
    if scene is not None:
        # what a scene holds already
        arguments_beside_scene = (
            profile,
            material,
            mean_normal_load,
            normal_amplitude,
            tangential_amplitude,
            phase_degrees,
            phase_radians,
        )
        has_mean_tangential_load = np.any(np.asarray(mean_tangential_load) != 0)
        if has_mean_tangential_load or any(value is not None for value in arguments_beside_scene):
            raise InputError("friction_from: a scene comes without profile, material and loads")
        return _friction_of_scene(dissipation, scene)

    profile_and_material = {"profile": profile, "material": material}
    load_values = (
        mean_normal_load,
        normal_amplitude,
        mean_tangential_load,
        tangential_amplitude,
        phase_in_radians(phase_degrees, phase_radians),
    )
    loads = dict(zip(_LOAD_NAMES, load_values, strict=True))
    missing_names = [
        name for name, value in (profile_and_material | loads).items() if value is None
    ]
    if missing_names:
        raise InputError(f"friction_from: {', '.join(missing_names)} is missing; or give a scene")
    return _friction_of_ellipses(dissipation, profile_and_material, loads)


def _friction_of_scene(dissipation: ArrayLike, scene: Scene) -> FrictionBatch:
    """Every coefficient of friction at which the steady cycle of a scene dissipates the measured W
    `dissipation` [energy per thickness]: elliptic loads by batches, other loads by `solve`.

    InputError for a scene with bulk stress, tilt or an unsymmetric profile.
    """
    scene = validated(scene, Scene)
    if scene.unsymmetric:
        raise InputError(
            "friction_from: it takes scenes of symmetric profiles without bulk stress and tilt;"
            " `solve` takes others"
        )
    if isinstance(scene.load, EllipseLoad):
        # _LOAD_NAMES: mean and amplitude of P, mean and amplitude of Q, lag of Q.
        loads = {name: getattr(scene.load, name) for name in _LOAD_NAMES}
        profile_and_material = {"profile": scene.profile, "material": scene.material}
        return _friction_of_ellipses(dissipation, profile_and_material, loads)
    return _friction_of_path(dissipation, scene)


def sliding_limit(
    mean_normal_load: Array,
    normal_amplitude: Array,
    mean_tangential_load: Array,
    tangential_amplitude: Array,
    phase: Array,
) -> Array:
    """The largest |Q|/P of load ellipses: the coefficient f below which they slide grossly;
    infinite where P reaches 0. Arrays broadcast.

    Loads are P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - `phase`) [rad], with P0 `mean_normal_load`,
    P1 `normal_amplitude`, Q0 `mean_tangential_load`, Q1 `tangential_amplitude`. Q - f P touches 0
    where (f P0 - Q0)^2 = Q1^2 - 2 f P1 Q1 cos(phase) + f^2 P1^2; Q + f P touches 0 where this holds
    with -Q0 and -Q1.

    >>> float(
    ...     sliding_limit(*(np.array(value) for value in (3.0, 0.0, 0.5, 1.0, 0.3)))
    ... )  # (Q0 + Q1)/P0
    0.5
    """
    # a f^2 - 2 b f = Q1^2 - Q0^2, whose larger root is the limit: a and b
    quadratic_factor = (mean_normal_load - normal_amplitude) * (mean_normal_load + normal_amplitude)
    half_linear_factor = np.abs(
        mean_normal_load * mean_tangential_load
        - normal_amplitude * tangential_amplitude * np.cos(phase)
    )
    root_of_discriminant = np.sqrt(
        np.maximum(
            half_linear_factor**2
            + quadratic_factor
            * (tangential_amplitude - mean_tangential_load)
            * (tangential_amplitude + mean_tangential_load),
            0.0,
        )
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(
            np.where(
                quadratic_factor > 0,
                (half_linear_factor + root_of_discriminant) / quadratic_factor,
                np.inf,
            )
        )


@dataclass(frozen=True)
class _EllipseBatch:
    """A batch of elliptic loads on a profile, m members, whose friction work is wanted at many
    coefficients of friction.

    Attributes
    ----------
    profile_and_material
        values of the arguments `profile` and `material` of `dissipation`
    loads
        its arguments for the ellipses, by name: mean and amplitude of P, mean and amplitude of Q,
        lag of Q, in this order, numbers or arrays
    shape
        shape of the batch, that of the loads and of the profile's numbers together
    """

    profile_and_material: dict[str, Any]
    loads: dict[str, Any]
    shape: tuple[int, ...]

    def values_of_members(
        self, name: str, value: Any, members: NDArray[np.intp] | slice = slice(None)
    ) -> Any:
        """An argument of `dissipation`, or a key of its profile, for k members of the batch, all if
        no `members` are stated: numbers as (k,).

        The list under the key "rises" of a profile gives a list of such arrays. The keys "kind" and
        "fitted" hold no numbers and are returned as they are.
        """
        if name == "rises":
            return [self.values_of_members("", rise, members) for rise in value]
        if name in ("kind", "fitted"):
            return value
        # as floats, of the shape of the batch
        return np.broadcast_to(real_numbers(value, name), self.shape).flat[members]

    def work(self, friction: Array, members: NDArray[np.intp]) -> Array:
        """Friction work of a steady cycle of n members of the batch, each at its own coefficient of
        friction (n,): (n,) [energy per thickness]. `members` (n,) are their indices in the batch.
        """
        loads_of_members = {
            name: self.values_of_members(name, value, members) for name, value in self.loads.items()
        }
        profile = self.profile_and_material["profile"]
        if isinstance(profile, Mapping):
            profile = {
                name: self.values_of_members(name, value, members)
                for name, value in profile.items()
            }
        dissipation_batch = dissipation(
            **self.profile_and_material | {"profile": profile},
            **loads_of_members,
            friction_coefficient=friction,
        )
        return dissipation_batch.value

    def least_friction_and_amplitude_ratio(self) -> tuple[Array, Array]:
        """f_min, the largest |Q|/P, and Q1/P1, 0 where P is constant, of all m members, (m,)
        each."""
        loads = {name: self.values_of_members(name, value) for name, value in self.loads.items()}
        normal_amplitude = loads["normal_amplitude"]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            least_friction = sliding_limit(*loads.values())
            amplitude_ratio = loads["tangential_amplitude"] / normal_amplitude
            return least_friction, np.where(normal_amplitude > 0, amplitude_ratio, 0.0)


def _friction_of_ellipses(
    measured_work: ArrayLike, profile_and_material: dict[str, Any], loads: dict[str, Any]
) -> FrictionBatch:
    """Every coefficient of friction at which elliptic loads dissipate `measured_work`, the measured
    W of a cycle [energy per thickness]; arrays broadcast.

    Parameters
    ----------
    profile_and_material
        values of the arguments `profile` and `material` of `dissipation`
    loads
        its arguments for the ellipses, by name: mean and amplitude of P, mean and amplitude of Q,
        lag of Q, in this order, numbers or arrays
    """
    # One call without friction checks every argument and gives the shape of the batch.
    frictionless_batch: DissipationBatch = dissipation(
        **profile_and_material, **loads, friction_coefficient=0.0
    )
    shape = frictionless_batch.value.shape
    ellipses = _EllipseBatch(profile_and_material, loads, shape)
    least_friction, force_over_load_amplitude = ellipses.least_friction_and_amplitude_ratio()
    return _friction_batch(
        measured_work,
        ellipses.work,
        least_friction,
        force_over_load_amplitude,
        shape,
        frictionless_batch.notes,
    )


def _friction_of_path(measured_work: ArrayLike, scene: Scene) -> FrictionBatch:
    """Every coefficient of friction at which a steady cycle of the scene dissipates
    `measured_work`, for loads other than an ellipse [energy per thickness].

    W, the friction work of a cycle, is found by `solve` at each coefficient tried. They begin at
    f_min, the largest |Q|/P of the path. Where no f within 1e-4 above it is admissible, no f is.
    """

    def work_at(friction: float) -> float:
        """W of the steady cycle at one f; InadmissibleLoadError where the contact slides."""
        scene_at_friction = scene.vary(friction=friction)
        return solve(scene_at_friction, x=0.0, fields="dissipation", cycles="steady").dissipation

    def work_of(friction: Array, _member: NDArray[np.intp]) -> Array:
        """W at coefficients (k,), (k,); the scene is the only member of its batch."""
        return np.array(
            [work_at(friction_coefficient) for friction_coefficient in friction.tolist()]
        )

    normal_load, tangential_load = _sampled_loads(scene.load.path())
    with np.errstate(divide="ignore", invalid="ignore"):
        largest_force_over_load = float(np.nanmax(np.abs(tangential_load) / normal_load))
    least_friction = _least_admissible_friction(work_at, largest_force_over_load)
    # range of Q over range of P, 0 where P is constant
    load_range_ratio = 0.0
    if float(np.ptp(normal_load)) > 1e-9 * float(np.max(np.abs(normal_load))):
        load_range_ratio = float(np.ptp(tangential_load) / np.ptp(normal_load))
    # a batch of one scene, of shape (), without notes
    return _friction_batch(
        measured_work, work_of, np.array([least_friction]), np.array([load_range_ratio]), (), ()
    )


def _sampled_loads(path: LoadPath) -> tuple[Array, Array]:
    """P and Q along a load path, (n,) each [force per thickness], at 513 samples of each segment of
    its initial loading and of its cycle.
    """
    loads_of_segments = [
        segment.loads(sampled_times(segment, 513))
        for segment in (*path.initial_loading, *path.cycle)
    ]
    normal_load, tangential_load = zip(*loads_of_segments, strict=True)
    return np.concatenate(normal_load), np.concatenate(tangential_load)


def _least_admissible_friction(
    work_at: Callable[[float], float], largest_load_ratio: float
) -> float:
    """The least of a few coefficients f at which the contact does not slide grossly: the largest
    |Q|/P of the samples of a load path, or up to 1e-4 of itself more; inf if it slides at all of
    them.

    Between the samples of a curved path |Q|/P may be a little larger than the largest sample.
    `work_at` gives the friction work of a cycle at one f, and raises InadmissibleLoadError where
    the contact slides.
    """
    for relative_excess in (0.0, *10.0 ** np.arange(-12, -3)):
        try:
            work_at(largest_load_ratio * (1 + relative_excess))
        except InadmissibleLoadError:
            continue
        return largest_load_ratio * (1 + float(relative_excess))
    return math.inf


class _WorkCurve(NamedTuple):
    """Samples of the friction work W(f), f the coefficient of friction, for m members of a batch.

    Attributes
    ----------
    log_f, works
        (k, m) ln f, ascending, and W at k samples of each member
    is_solvable
        (m,) whether W of the member is known at all its samples
    largest_f
        (m,) largest sampled f
    """

    log_f: Array
    works: Array
    is_solvable: NDArray[np.bool_]
    largest_f: Array


WorkFunction = Callable[[Array, NDArray[np.intp]], Array]
"""Function that gives friction works W (k,) for coefficients of friction (k,) and member indices
(k,).
"""


class _Targets(NamedTuple):
    """Measured friction works W of a batch, and the member of the batch that each belongs to.

    Attributes
    ----------
    works
        (n,) W of a cycle [energy per thickness]; may be invalid: not finite, or not above 0
    member
        (n,) index of the member of the batch
    shape
        shape of the n targets as the caller gave them, broadcast with the batch
    """

    works: Array
    member: NDArray[np.intp]
    shape: tuple[int, ...]

    @classmethod
    def of_measured(cls, dissipation: ArrayLike, shape: tuple[int, ...]) -> _Targets:
        """The measured works W of a cycle that the members of a batch are to reach, one after the
        other, each with the number of its member; `dissipation` broadcasts with the batch's
        `shape`.

        InputError where it does not broadcast, or has values that are no real numbers.
        """
        measured_works = real_numbers(dissipation, "dissipation")
        try:
            full_shape = np.broadcast_shapes(measured_works.shape, shape)
        except ValueError as fault:
            raise InputError(
                "friction_from: the dissipation must be numbers that broadcast with the loads:"
                f" {fault}"
            ) from fault
        member = np.arange(math.prod(shape)).reshape(shape)
        return cls(
            works=np.broadcast_to(measured_works, full_shape).ravel(),
            member=np.broadcast_to(member, full_shape).ravel(),
            shape=full_shape,
        )


def _friction_batch(
    measured_dissipation: ArrayLike,
    work_of: WorkFunction,
    least_friction_of_member: Array,
    load_amplitude_ratio: Array,
    shape: tuple[int, ...],
    notes: tuple[str, ...],
) -> FrictionBatch:
    """Every coefficient of friction at which the friction work W of a cycle is the measured one,
    with the reason where there is none.

    W(f) of each of m members of a batch is sampled, and its turning points are added. Between
    samples on either side of the measured W the roots are then found by iteration. There are n
    measured W after broadcasting.

    Parameters
    ----------
    measured_dissipation
        W of a cycle [energy per thickness], which broadcasts with the batch
    work_of
        function that gives W by coefficients of friction and the indices of members
    least_friction_of_member, load_amplitude_ratio
        (m,) f_min, below which the member slides grossly, and Q1/P1, the amplitude of Q over that
        of P, 0 where P is constant
    shape
        shape of the batch, m members in all
    notes
        sentences of the batch that the result hands on
    """
    targets = _Targets.of_measured(measured_dissipation, shape)
    # W as a function of ln f, (samples, m): first samples, then turning points among them
    work_curve = _sampled_work(work_of, least_friction_of_member, load_amplitude_ratio)
    work_curve = _with_turning_points(work_curve, work_of)
    friction_roots = _roots_of(work_curve, work_of, targets)
    work_limits = _limits_of(work_curve, least_friction_of_member, targets)
    reason_codes = _reasons_without_root(targets, friction_roots, work_limits)
    has_root = reason_codes == NoFriction.NONE
    root_rows = np.where(has_root[:, None], friction_roots.rows, np.nan)
    sentences = _sentences_of_reasons(reason_codes, targets, work_limits)

    # results in the broadcast shape; no limits for loads that no f admits
    def in_full_shape(limit_values: Array) -> Array:
        """Values of the n targets (n,), NaN where no f admits the loads, in the broadcast shape."""
        return read_only_copy(
            np.where(work_limits.is_solvable, limit_values, np.nan).reshape(targets.shape)
        )

    return FrictionBatch(
        roots=read_only_copy(root_rows.reshape(*targets.shape, -1)),
        count=read_only_copy(
            np.where(has_root, friction_roots.n_roots, 0).reshape(targets.shape), np.int64
        ),
        reason=read_only_copy(reason_codes.reshape(targets.shape), np.int8),
        least_friction=in_full_shape(work_limits.least_friction),
        least=in_full_shape(work_limits.least_work),
        most=in_full_shape(work_limits.most_work),
        sentences=sentences,
        notes=notes,
    )


class _Limits(NamedTuple):
    """What the loads of each of n targets (measured friction works W) admit, (n,) each.

    Attributes
    ----------
    is_solvable
        whether W of the loads is known at all sampled coefficients f
    least_friction, largest_f
        f_min, below which the contact slides grossly; the largest f sampled
    least_work, most_work
        least and largest W at any sampled f [energy per thickness]
    """

    is_solvable: NDArray[np.bool_]
    least_friction: Array
    largest_f: Array
    least_work: Array
    most_work: Array


def _limits_of(
    work_curve: _WorkCurve, least_friction_of_member: Array, targets: _Targets
) -> _Limits:
    """Least and largest friction work W that the loads of each of n targets dissipate at any
    sampled coefficient f, and the range of f.

    `work_curve` has ln f and W(f), (k, m), for m members of a batch; `least_friction_of_member`
    (m,) is f_min; `targets.member` (n,) is the member of each target.
    """
    is_work_known = np.isfinite(work_curve.works)
    member_of_target = targets.member
    return _Limits(
        is_solvable=work_curve.is_solvable[member_of_target],
        least_friction=least_friction_of_member[member_of_target],
        largest_f=work_curve.largest_f[member_of_target],
        least_work=np.min(np.where(is_work_known, work_curve.works, np.inf), axis=0)[
            member_of_target
        ],
        most_work=np.max(np.where(is_work_known, work_curve.works, -np.inf), axis=0)[
            member_of_target
        ],
    )


def _reasons_without_root(
    targets: _Targets, friction_roots: _Roots, work_limits: _Limits
) -> NDArray[np.int8]:
    """Why no coefficient of friction gives the measured friction work of each of n targets, (n,) of
    `NoFriction` as int8; 0 where there is a root.
    """
    # The first condition that holds is the reason.
    conditions = {
        NoFriction.INVALID: ~(np.isfinite(targets.works) & (targets.works > 0)),
        NoFriction.LOADS: ~work_limits.is_solvable,
        NoFriction.UNSETTLED: friction_roots.is_not_converged,
        NoFriction.TOO_MUCH: (friction_roots.n_roots == 0)
        & (targets.works > work_limits.most_work),
        NoFriction.TOO_LITTLE: friction_roots.n_roots == 0,
    }
    return np.select([*conditions.values()], [*conditions], NoFriction.NONE).astype(np.int8)


def _sentences_of_reasons(
    reason_codes: NDArray[np.int8], targets: _Targets, work_limits: _Limits
) -> tuple[str, ...]:
    """One sentence for each target without a root, at most ten: why no coefficient of friction
    gives its measured work. `reason_codes` (n,) is `NoFriction` of each of the n targets.
    """
    return tuple(
        _SENTENCE_OF_REASON[NoFriction(reason_codes[target_number])].format(
            target=targets.works[target_number],
            least=work_limits.least_work[target_number],
            most=work_limits.most_work[target_number],
            f_min=work_limits.least_friction[target_number],
            top=work_limits.largest_f[target_number],
        )
        for target_number in np.flatnonzero(reason_codes)[:10]
    )


def _sampled_work(
    work_of: WorkFunction, least_friction: Array, load_amplitude_ratio: Array
) -> _WorkCurve:
    """Friction work W of m members of a batch at samples of the coefficient of friction f.

    They reach from f_min up to 1e6 times the larger of f_min and Q1/P1. f_min = `least_friction`
    (m,) is the least f without gross sliding, Q1/P1 = `load_amplitude_ratio` (m,) the ratio of the
    amplitudes of Q and P. Samples are dense next to f_min and sparse beyond 100 times the
    larger. A member is solvable where f_min and all its W are finite. `work_of` gives W by
    coefficients and the indices of members.
    """
    n_members = len(least_friction)
    is_solvable = np.isfinite(least_friction) & (least_friction > 0)
    # beyond f_min by 1e-12, its round-off
    first_f = np.where(is_solvable, least_friction, 1.0) * (1 + _ROUNDOFF_OF_LIMIT)
    middle_f = (
        np.maximum(first_f, np.where(is_solvable, load_amplitude_ratio, 0.0)) * _MIDDLE_FACTOR
    )
    largest_f = middle_f * (_LARGEST_FACTOR / _MIDDLE_FACTOR)
    # 17 samples of f/f_min - 1 up to 0.05, then 72 and 9 more
    relative_excess = np.concatenate(
        [[0.0], np.logspace(-8, math.log10(0.05), _SAMPLES_CLOSE_TO_SLIDING - 1)]
    )
    # (98, m): close to gross sliding, evenly spread, and far from it
    log_f = np.concatenate(
        [
            np.log(first_f) + np.log1p(relative_excess)[:, None],
            np.linspace(np.log(first_f * 1.08), np.log(middle_f), _EVEN_SAMPLES),
            np.linspace(np.log(middle_f), np.log(largest_f), _FAR_SAMPLES + 1)[1:],
        ]
    )
    member = np.broadcast_to(np.arange(n_members), log_f.shape)
    works = np.full(log_f.shape, np.nan)
    solvable_works = work_of(np.exp(log_f[:, is_solvable]).ravel(), member[:, is_solvable].ravel())
    works[:, is_solvable] = solvable_works.reshape(len(log_f), -1)
    is_solvable &= np.all(np.isfinite(works), axis=0)
    return _WorkCurve(log_f, works, is_solvable, largest_f)


def _with_turning_points(work_curve: _WorkCurve, work_of: WorkFunction) -> _WorkCurve:
    """The samples of friction work W(f), f the coefficient of friction, with the extrema of W
    between them added as samples.

    Between two samples an extremum may hide two roots. `work_of` gives W by coefficients and the
    indices of members of the batch. `work_curve` holds ln f and W, (samples, m) each, and whether W
    of a member is known at all its samples.
    """
    first_sample, member = _samples_before_extrema(work_curve)
    if not len(first_sample):
        return work_curve
    log_f_of_extremum, work_of_extremum = _extrema_of_work(
        work_curve, work_of, first_sample, member
    )

    # (rows, m): the first row for the first extremum of each member, the next for its second, ...
    number_within_member = np.arange(len(first_sample)) - np.searchsorted(
        np.sort(member), np.sort(member)
    )
    order_by_member = np.argsort(member, kind="stable")
    log_f_rows = np.full((int(number_within_member.max()) + 1, work_curve.works.shape[1]), np.nan)
    work_rows = log_f_rows.copy()
    log_f_rows[number_within_member, member[order_by_member]] = log_f_of_extremum[order_by_member]
    work_rows[number_within_member, member[order_by_member]] = work_of_extremum[order_by_member]

    log_f = np.concatenate([work_curve.log_f, log_f_rows])
    works = np.concatenate([work_curve.works, work_rows])
    ascending_order = np.argsort(log_f, axis=0)
    return work_curve._replace(
        log_f=np.take_along_axis(log_f, ascending_order, 0),
        works=np.take_along_axis(works, ascending_order, 0),
    )


def _samples_before_extrema(work_curve: _WorkCurve) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where the friction work W(f) turns, f the coefficient of friction, within three neighbouring
    samples: the number of the first of them, and the member of the batch, (e,) each for e extrema.

    `work_curve` has W at the samples, (k, m) for m members. Members whose W is not known at all
    samples are left out, as are changes of W below 1e-10 of its largest value, which are round-off.
    """
    work_changes = np.diff(work_curve.works, axis=0)
    largest_work = np.max(np.where(work_curve.is_solvable, work_curve.works, 0.0), axis=0)
    # _LEAST_RISE: 1e-10.
    is_above_roundoff = (
        np.minimum(np.abs(work_changes[:-1]), np.abs(work_changes[1:]))
        >= _LEAST_RISE * largest_work
    )
    turns = work_changes[:-1] * work_changes[1:] < 0
    first_sample, member = np.nonzero(work_curve.is_solvable & is_above_roundoff & turns)
    return first_sample, member


def _extrema_of_work(
    work_curve: _WorkCurve,
    work_of: WorkFunction,
    first_sample: NDArray[np.intp],
    member: NDArray[np.intp],
) -> tuple[Array, Array]:
    """Extrema of the friction work W(f), f the coefficient of friction: ln f and W there, (e,)
    each, by iteration within three samples on which W turns.

    Parameters
    ----------
    work_curve
        ln f and W at the samples, (k, m) for m members of a batch
    work_of
        function that gives W by coefficients of friction and the indices of members
    first_sample, member
        (e,) number of the first of the three samples, and the member
    """
    # `scipy.optimize` alone does not load it
    from scipy.optimize import elementwise  # noqa: PLC0415

    first_change = np.diff(work_curve.works, axis=0)[first_sample, member]
    # W falls before a minimum; of a maximum -W is minimised.
    sign_to_minimum = np.where(first_change < 0, 1.0, -1.0)
    minimum_search = elementwise.find_minimum(
        lambda log_f_at_trial, member_of_trial, sign: (
            sign * _work_by_log_f(work_of, log_f_at_trial, member_of_trial)
        ),
        tuple(work_curve.log_f[first_sample + k, member] for k in (0, 1, 2)),
        args=(member.astype(float), sign_to_minimum),
    )
    return minimum_search.x, sign_to_minimum * minimum_search.f_x


def _work_by_log_f(work_of: WorkFunction, log_f: Array, member: Array) -> Array:
    """Friction work W at ln f of members of a batch, arrays of one shape of any rank.

    `work_of` gives W by coefficients and the indices of members, (k,) each. `member` are these
    indices as floats, as a search of scipy passes them.
    """
    return work_of(np.exp(log_f).ravel(), member.ravel().astype(int)).reshape(log_f.shape)


class _Roots(NamedTuple):
    """Coefficients f at which the friction work W is that of each of n targets.

    Attributes
    ----------
    rows
        (n, k) the f of each target, ascending, NaN behind the last; k is the largest number of
        them, at least 1
    n_roots
        (n,) how many f each target has
    is_not_converged
        (n,) whether the search for one of them failed
    """

    rows: Array
    n_roots: NDArray[np.intp]
    is_not_converged: NDArray[np.bool_]


def _roots_of(work_curve: _WorkCurve, work_of: WorkFunction, targets: _Targets) -> _Roots:
    """Every coefficient f at which the friction work W of a member of a batch is its target, the
    measured W.

    Each pair of neighbouring samples with the target between their W encloses one root.

    Parameters
    ----------
    work_curve
        samples of ln f and W(f) for each of m members, (samples, m), turning points included
    work_of
        function that gives W by coefficients of friction and the indices of members
    targets
        n measured W, and the member of each
    """
    sample_before_root, target_of_root = _samples_before_roots(work_curve, targets)
    n_roots = np.bincount(target_of_root, minlength=len(targets.works))
    root_rows = np.full((len(targets.works), max(1, int(n_roots.max(initial=0)))), np.nan)
    is_not_converged = np.zeros(len(targets.works), dtype=bool)
    if not len(sample_before_root):
        return _Roots(root_rows, n_roots, is_not_converged)

    # `scipy.optimize` alone does not load it
    from scipy.optimize import elementwise  # noqa: PLC0415

    member_of_root = targets.member[target_of_root]
    target_works = targets.works[target_of_root]
    # iteration over ln f between two samples
    root_search = elementwise.find_root(
        lambda log_f_at_trial, member_of_trial, work_at_root: (
            _work_by_log_f(work_of, log_f_at_trial, member_of_trial) - work_at_root
        ),
        (
            work_curve.log_f[sample_before_root, member_of_root],
            work_curve.log_f[sample_before_root + 1, member_of_root],
        ),
        args=(member_of_root.astype(float), target_works),
    )
    # each root in the row of its target, in ascending order
    place_in_row = np.arange(len(target_of_root)) - np.searchsorted(target_of_root, target_of_root)
    root_rows[target_of_root, place_in_row] = np.exp(root_search.x)
    # a residual above 1e-8 of the target: not found
    is_found = np.abs(root_search.f_x) <= _LARGEST_RESIDUAL * target_works
    is_not_converged[target_of_root[~is_found]] = True
    return _Roots(root_rows, n_roots, is_not_converged)


def _samples_before_roots(
    work_curve: _WorkCurve, targets: _Targets
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where the friction work W of a member passes its target between two neighbouring samples: the
    number of the sample below in f, and that of the target, (r,) each for r roots. They are sorted
    by the target, then by f.

    `work_curve` has W at the samples, (k, m) for m members of a batch. Targets that are not finite,
    not above 0, or of members whose W is not known at all samples, have none.
    """
    target_works = targets.works
    sampled_works = work_curve.works[:, targets.member]
    is_valid_target = (
        np.isfinite(target_works) & (target_works > 0) & work_curve.is_solvable[targets.member]
    )
    is_above_target = sampled_works > np.where(is_valid_target, target_works, np.inf)
    is_work_known = np.isfinite(sampled_works)
    encloses_root = (
        (is_above_target[:-1] != is_above_target[1:])
        & is_work_known[:-1]
        & is_work_known[1:]
        & is_valid_target
    )
    sample_before_root, target_of_root = np.nonzero(encloses_root)
    order_by_target = np.lexsort((sample_before_root, target_of_root))
    return sample_before_root[order_by_target], target_of_root[order_by_target]
