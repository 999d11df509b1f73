"""The coefficient of friction from a measured dissipation: every f at which a cycle of given loads
dissipates W.

# notation: A = 2/E*, W dissipation of a steady cycle, W_inf its limit for f without bound, f_min
least f without gross sliding

At constant P, W falls steadily from f_min on, to 0 as 1/f: one f for each W. Where P varies, W does
not vanish with growing f: what shrinking contact sets free is lost however rough the faces are. For
an ellipse

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
    Materials,
    Profile,
    Scene,
    freeze,
    sampled,
)
from scenes.array_types import Array
from scenes.arrays import real_numbers
from scenes.frozen import validated
from semi_analytic.batches import DissipationBatch, dissipation
from semi_analytic.phases import accepts_phase, phase_in_radians
from semi_analytic.solution import solve

# Samples of W in f over f_min: 1 + 10^k close to sliding, where W has all its changes in P_T; by
# the logarithm up to _MIDDLE of f_min or Q1/P1, whichever is more, by which W has all its turning
# points; few beyond, where it only nears W_inf.
_CLOSE = 17
_EVEN = 72
_FAR = 9
_MIDDLE = 1e2
_MOST = 1e6
# f_min itself is admitted, but for its own rounding.
_BESIDE = 1e-12
# Of W: a turning point that stands out by less is round-off, and a root that misses by more was not
# found.
_STANDS_OUT = 1e-10
_FOUND = 1e-8
_LOADS = (
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


_SENTENCES = {
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
        dissipation at the f that give the least and the most [energy per unit thickness]
    sentences
        one for each member without a root, at most ten
    notes
        as in `DissipationBatch`
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
        coefficient counts for nothing
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
        with all roots: one, or two or three where P varies. W(f) is sampled at 98 coefficients
        from gross sliding to 10^6 times the larger of f_min and Q1/P1; its turning points and
        roots are then refined. A root is good to 1e-10 of itself, close to a turning point of W
        to 1e-5. A member of Hertz takes 0.2 ms, of a table 50 ms, a scene whose load is no
        ellipse seconds.

    Raises
    ------
    InputError
        For a scene beside other arguments, for arguments that are missing, and as `dissipation`.

    Examples
    --------
    >>> from scenes import load_scene
    >>> scene = load_scene("hertz-paper")  # f = 1, near the least value of W(f)
    >>> work = solve(scene, x=0.0, fields="dissipation").dissipation
    >>> [round(root, 4) for root in friction_from(work, scene=scene).roots.tolist()]
    [1.0, 1.0411]
    """
    if scene is None:
        pair = {"profile": profile, "material": material}
        load_values = (
            mean_normal_load,
            normal_amplitude,
            mean_tangential_load,
            tangential_amplitude,
            phase_in_radians(phase_degrees, phase_radians),
        )
        loads = dict(zip(_LOADS, load_values, strict=True))
        missing_names = [name for name, value in (pair | loads).items() if value is None]
        if missing_names:
            raise InputError(
                f"friction_from: {', '.join(missing_names)} is missing; or give a scene"
            )
        return _of_ellipses(dissipation, pair, loads)
    parts_of_scene = (
        profile,
        material,
        mean_normal_load,
        normal_amplitude,
        tangential_amplitude,
        phase_degrees,
        phase_radians,
    )
    if any(value is not None for value in parts_of_scene):
        raise InputError("friction_from: a scene comes without profile, material and loads")
    scene = validated(scene, Scene)
    if scene.unsymmetric:
        raise InputError(
            "friction_from: it takes scenes of symmetric profiles without bulk stress and tilt;"
            " `solve` takes others"
        )
    if isinstance(scene.load, EllipseLoad):
        loads = {name: getattr(scene.load, name) for name in _LOADS}
        pair = {"profile": scene.profile, "material": scene.material}
        return _of_ellipses(dissipation, pair, loads)
    return _of_path(dissipation, scene)


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
    where (f P0 - Q0)^2 = Q1^2 - 2 f P1 Q1 cos(phase) + f^2 P1^2, and so does Q + f P with Q0
    turned.

    >>> float(
    ...     sliding_limit(*(np.array(value) for value in (3.0, 0.0, 0.5, 1.0, 0.3)))
    ... )  # (Q0 + Q1)/P0
    0.5
    """
    # notation: a f^2 - 2 b f = Q1^2 - Q0^2, whose larger root is the limit
    a = (mean_normal_load - normal_amplitude) * (mean_normal_load + normal_amplitude)
    b = np.abs(
        mean_normal_load * mean_tangential_load
        - normal_amplitude * tangential_amplitude * np.cos(phase)
    )
    root_of_discriminant = np.sqrt(
        np.maximum(
            b**2
            + a
            * (tangential_amplitude - mean_tangential_load)
            * (tangential_amplitude + mean_tangential_load),
            0.0,
        )
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(a > 0, (b + root_of_discriminant) / a, np.inf))


def _of_ellipses(
    target: ArrayLike, profile_and_material: dict[str, Any], loads: dict[str, Any]
) -> FrictionBatch:
    """Every coefficient of friction at which elliptic loads dissipate the `target`, the measured W
    of a cycle [energy per thickness].

    Parameters
    ----------
    profile_and_material
        profile and material by these names
    loads
        numbers or arrays of the ellipses, by the names of the arguments of `dissipation`
    """
    # One call without friction checks every argument and gives the shape of the loads and of the
    # profile's numbers.
    frictionless: DissipationBatch = dissipation(
        **profile_and_material, **loads, friction_coefficient=0.0
    )
    shape = frictionless.value.shape
    profile = profile_and_material["profile"]

    def of_members(name: str, value: Any, members: NDArray[np.intp] | slice) -> Any:
        """The values (k,) of an argument for some members."""
        if name == "rises":
            return [of_members("", rise, members) for rise in value]
        if name in ("kind", "fitted"):
            return value
        return np.broadcast_to(real_numbers(value, name), shape).flat[members]

    def work(friction: Array, members: NDArray[np.intp]) -> Array:
        """Friction work per cycle of members of the batch, numbers (n,), each with its own
        coefficient of friction (n,): (n,).
        """
        loads_of_members = {name: of_members(name, value, members) for name, value in loads.items()}
        profile_of_members = profile
        if isinstance(profile, Mapping):
            profile_of_members = {
                name: of_members(name, value, members) for name, value in profile.items()
            }
        batch = dissipation(
            **profile_and_material | {"profile": profile_of_members},
            **loads_of_members,
            friction_coefficient=friction,
        )
        return batch.value

    flat_loads = {name: of_members(name, value, slice(None)) for name, value in loads.items()}
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        least_friction = sliding_limit(*flat_loads.values())
        amplitude_ratio = flat_loads["tangential_amplitude"] / flat_loads["normal_amplitude"]
        no_slip = np.where(flat_loads["normal_amplitude"] > 0, amplitude_ratio, 0.0)
    return _inverse(target, work, least_friction, no_slip, shape, frictionless.notes)


def _of_path(target: ArrayLike, scene: Scene) -> FrictionBatch:
    """Every coefficient of friction at which a steady cycle of the scene dissipates `target`, for
    loads that are no ellipse: W by `solve` at each coefficient that is tried.

    The search begins at the least coefficient without gross sliding, the largest |Q|/P of the path.
    """

    def work_at(friction: float) -> float:
        scene_at = scene.vary(friction=friction)
        return solve(scene_at, x=0.0, fields="dissipation", cycles="steady").dissipation

    path = scene.load.path()
    loads_of_legs = [leg.loads(sampled(leg, 513)) for leg in (*path.initial_loading, *path.cycle)]
    with np.errstate(divide="ignore", invalid="ignore"):
        least_friction = max(
            float(np.nanmax(np.abs(tangential_load) / normal_load))
            for normal_load, tangential_load in loads_of_legs
        )
    # Between the samples of a curved path |Q|/P may be a little larger.
    for relative_excess in (0.0, *10.0 ** np.arange(-12, -3)):
        try:
            work_at(least_friction * (1 + relative_excess))
        except InadmissibleLoadError:
            continue
        least_friction *= 1 + float(relative_excess)
        break
    else:
        least_friction = math.inf
    normal_load = np.concatenate([loads_of_leg[0] for loads_of_leg in loads_of_legs])
    tangential_load = np.concatenate([loads_of_leg[1] for loads_of_leg in loads_of_legs])
    load_varies = float(np.ptp(normal_load)) > 1e-9 * float(np.max(np.abs(normal_load)))
    no_slip = float(np.ptp(tangential_load) / np.ptp(normal_load)) if load_varies else 0.0

    def work(friction: Array, _member: NDArray[np.intp]) -> Array:
        return np.array([work_at(coefficient) for coefficient in friction.tolist()])

    return _inverse(target, work, np.array([least_friction]), np.array([no_slip]), (), ())


class _WorkCurve(NamedTuple):
    """W over the coefficient of friction: ln f and W of each member, ascending in f, (k, m) each;
    whether W of a member is known, and its largest f, (m,) each.
    """

    log_f: Array
    works: Array
    is_solvable: NDArray[np.bool_]
    largest_f: Array


Work = Callable[[Array, NDArray[np.intp]], Array]
"""W (k,) by coefficients of friction and the numbers of their members, (k,) each."""


def _inverse(
    target: ArrayLike,
    work: Work,
    least_friction_of_member: Array,
    no_slip: Array,
    shape: tuple[int, ...],
    notes: tuple[str, ...],
) -> FrictionBatch:
    """Every coefficient of friction at which the friction work W of a cycle is the measured
    `target`, with the reason where there is none.

    Each member of a batch has its own curve W(f), which is sampled, refined at its turning points
    and intersected.

    Parameters
    ----------
    work
        function that gives W by coefficients and the numbers of their members
    least_friction_of_member, no_slip
        (m,) f_min and Q1/P1 of the members; beyond Q1/P1 nothing slips
    shape
        shape of the members' arrays
    notes
        what a reader of the result must not miss
    """
    target_works = real_numbers(target, "dissipation")
    try:
        full_shape = np.broadcast_shapes(target_works.shape, shape)
    except ValueError as fault:
        raise InputError(
            f"friction_from: the dissipation must be numbers that broadcast with the loads: {fault}"
        ) from fault
    curve = _sampled_work(work, least_friction_of_member, no_slip)
    curve = _with_turning_points(curve, work)
    n_members = len(least_friction_of_member)
    member = np.broadcast_to(np.arange(n_members).reshape(shape), full_shape).ravel()
    flat_targets = np.broadcast_to(target_works, full_shape).ravel()
    roots, n_roots, is_unsettled = _roots_of(curve, work, member, flat_targets)
    is_known = np.isfinite(curve.works)
    least_work = np.min(np.where(is_known, curve.works, np.inf), axis=0)[member]
    most_work = np.max(np.where(is_known, curve.works, -np.inf), axis=0)[member]
    is_solvable = curve.is_solvable[member]
    # The first condition that holds is the reason.
    conditions = {
        NoFriction.INVALID: ~(np.isfinite(flat_targets) & (flat_targets > 0)),
        NoFriction.LOADS: ~is_solvable,
        NoFriction.UNSETTLED: is_unsettled,
        NoFriction.TOO_MUCH: (n_roots == 0) & (flat_targets > most_work),
        NoFriction.TOO_LITTLE: n_roots == 0,
    }
    reason = np.select([*conditions.values()], [*conditions], NoFriction.NONE).astype(np.int8)
    roots[reason != NoFriction.NONE] = np.nan
    sentences = tuple(
        _SENTENCES[NoFriction(reason[k])].format(
            target=flat_targets[k],
            least=least_work[k],
            most=most_work[k],
            f_min=least_friction_of_member[member[k]],
            top=curve.largest_f[member[k]],
        )
        for k in np.flatnonzero(reason)[:10]
    )
    count = np.where(reason == NoFriction.NONE, n_roots, 0)
    limits = (
        np.where(is_solvable, values, np.nan).reshape(full_shape)
        for values in (least_friction_of_member[member], least_work, most_work)
    )
    least_friction, least_work, most_work = (freeze(values) for values in limits)
    return FrictionBatch(
        roots=freeze(roots.reshape(*full_shape, -1)),
        count=freeze(count.reshape(full_shape), np.int64),
        reason=freeze(reason.reshape(full_shape), np.int8),
        least_friction=least_friction,
        least=least_work,
        most=most_work,
        sentences=sentences,
        notes=notes,
    )


def _sampled_work(work: Work, least_friction: Array, no_slip: Array) -> _WorkCurve:
    """Friction work W at samples of the coefficient f between the least without gross sliding and
    the largest that is looked at, for each member of a batch.

    Samples are dense next to f_min = `least_friction` (m,), and go up to 100 times the larger of
    f_min and Q1/P1 = `no_slip`, then further apart. `work` gives W by coefficients f and the
    numbers of their members.
    """
    n_members = len(least_friction)
    is_solvable = np.isfinite(least_friction) & (least_friction > 0)
    least_f = np.where(is_solvable, least_friction, 1.0) * (1 + _BESIDE)
    middle_f = np.maximum(least_f, np.where(is_solvable, no_slip, 0.0)) * _MIDDLE
    largest_f = middle_f * (_MOST / _MIDDLE)
    shares = np.concatenate([[0.0], np.logspace(-8, math.log10(0.05), _CLOSE - 1)])
    log_f = np.concatenate(
        [
            np.log(least_f) + np.log1p(shares)[:, None],
            np.linspace(np.log(least_f * 1.08), np.log(middle_f), _EVEN),
            np.linspace(np.log(middle_f), np.log(largest_f), _FAR + 1)[1:],
        ]
    )
    member = np.broadcast_to(np.arange(n_members), log_f.shape)
    works = np.full(log_f.shape, np.nan)
    solvable_works = work(np.exp(log_f[:, is_solvable]).ravel(), member[:, is_solvable].ravel())
    works[:, is_solvable] = solvable_works.reshape(len(log_f), -1)
    is_solvable &= np.all(np.isfinite(works), axis=0)
    return _WorkCurve(log_f, works, is_solvable, largest_f)


def _with_turning_points(curve: _WorkCurve, work: Work) -> _WorkCurve:
    """The sampled curve of friction work W over the coefficient f, with the turning points of W
    among its samples.

    A turning point may lie between two samples and hide two roots. `work` gives W by coefficients
    and the numbers of their members.
    """
    # `scipy.optimize` alone does not load it
    from scipy.optimize import elementwise  # noqa: PLC0415

    log_f, works, is_solvable, _ = curve
    rise = np.diff(works, axis=0)
    largest_work = np.max(np.where(is_solvable, works, 0.0), axis=0)
    stands_out = np.minimum(np.abs(rise[:-1]), np.abs(rise[1:])) >= _STANDS_OUT * largest_work
    sample, member_of_turn = np.nonzero(is_solvable & stands_out & (rise[:-1] * rise[1:] < 0))
    if not len(sample):
        return curve
    sign_to_minimum = np.where(
        rise[sample, member_of_turn] < 0, 1.0, -1.0
    )  # W falls before a least value
    turning_point = elementwise.find_minimum(
        lambda log_f_at_trial, member, sense: (
            sense
            * work(np.exp(log_f_at_trial).ravel(), member.ravel().astype(int)).reshape(
                log_f_at_trial.shape
            )
        ),
        tuple(log_f[sample + k, member_of_turn] for k in (0, 1, 2)),
        args=(member_of_turn.astype(float), sign_to_minimum),
    )
    number_of_turn = np.arange(len(sample)) - np.searchsorted(
        np.sort(member_of_turn), np.sort(member_of_turn)
    )
    order_by_member = np.argsort(member_of_turn, kind="stable")
    log_f_at_turn = np.full((int(number_of_turn.max()) + 1, works.shape[1]), np.nan)
    work_at_turn = log_f_at_turn.copy()
    log_f_at_turn[number_of_turn, member_of_turn[order_by_member]] = turning_point.x[
        order_by_member
    ]
    work_at_turn[number_of_turn, member_of_turn[order_by_member]] = (
        sign_to_minimum * turning_point.f_x
    )[order_by_member]
    log_f = np.concatenate([log_f, log_f_at_turn])
    works = np.concatenate([works, work_at_turn])
    ascending = np.argsort(log_f, axis=0)
    return curve._replace(
        log_f=np.take_along_axis(log_f, ascending, 0),
        works=np.take_along_axis(works, ascending, 0),
    )


def _roots_of(
    curve: _WorkCurve, work: Work, member: NDArray[np.intp], target: Array
) -> tuple[Array, NDArray[np.intp], NDArray[np.bool_]]:
    """Every coefficient f at which the friction work W of a member is its target: (n, k), NaN
    behind the last root of each; the number of roots, and whether the search did not converge, (n,)
    each.

    Between two samples of W on either side of the target there is one root.

    Parameters
    ----------
    curve
        W at samples of f for each member
    work
        function that gives W by coefficients and the numbers of their members
    member, target
        (n,) number of the member, and W
    """
    # `scipy.optimize` alone does not load it
    from scipy.optimize import elementwise  # noqa: PLC0415

    log_f, works, is_solvable, _ = curve
    is_valid = np.isfinite(target) & (target > 0) & is_solvable[member]
    is_above = works[:, member] > np.where(is_valid, target, np.inf)
    is_known = np.isfinite(works[:, member])
    crosses = (is_above[:-1] != is_above[1:]) & is_known[:-1] & is_known[1:] & is_valid
    sample, number_of_target = np.nonzero(crosses)
    order_by_target = np.lexsort((sample, number_of_target))
    sample = sample[order_by_target]
    number_of_target = number_of_target[order_by_target]
    n_roots = np.bincount(number_of_target, minlength=len(target))
    roots = np.full((len(target), max(1, int(n_roots.max(initial=0)))), np.nan)
    is_unsettled = np.zeros(len(target), dtype=bool)
    if len(sample):
        member_of_root = member[number_of_target]
        crossing = elementwise.find_root(
            lambda log_f_at_trial, member_of_trial, goal_work: (
                work(np.exp(log_f_at_trial).ravel(), member_of_trial.ravel().astype(int)).reshape(
                    log_f_at_trial.shape
                )
                - goal_work
            ),
            (log_f[sample, member_of_root], log_f[sample + 1, member_of_root]),
            args=(member_of_root.astype(float), target[number_of_target]),
        )
        roots[
            number_of_target,
            np.arange(len(sample)) - np.searchsorted(number_of_target, number_of_target),
        ] = np.exp(crossing.x)
        is_unsettled[
            number_of_target[~(np.abs(crossing.f_x) <= _FOUND * target[number_of_target])]
        ] = True
    return roots, n_roots, is_unsettled
