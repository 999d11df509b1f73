"""Dissipation and its peak for arrays of ellipses: the two calls that sweeps and the paper's figures 7 and 10 need.

Arguments are broadcast and taken block by block, so that memory beyond arguments and results is that of one block. Bad members get
a reason. The others are sorted by profile: those that differ by units only share one contact, that of the same profile in units of
its own; a profile of b, R1 and R2, say, is that of 1, 1 and R2/R1 in the units b and E* b^2/R1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ValidationError

from scenes import (
    Compound,
    Elastic,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    PowerLaw,
    Profile,
    Wedge,
)
from scenes.frozen import Frozen, validated
from semi_analytic.density_peaks import maxima_of
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import Contact, contact_of
from semi_analytic.slip_work import LamTable, careful_bracket, dissipation_of, quick_bracket, works_by_lam
from semi_analytic.solution import neglected_coupling
from semi_analytic.steady_ellipse import Ellipses, ellipses_of

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_BLOCK = 16384
# Shares of P0 that P - P_c must reach for the quick way to Lam, which there loses 6e-11 of W by formulas, 1e-12 by the table.
_DEEP, _DEEP_ON_TABLE = 0.02, 0.04
_LEAST = float(np.finfo(float).tiny)
_HALF = Elastic(young_modulus=2.0, poisson_ratio=0.0)  # against itself E* = 1


class Reason(IntEnum):
    """Why a member of a batch has no value."""

    NONE = 0
    SLIDING = 1
    SEPARATION = 2
    INVALID = 3
    EXTENT = 4
    UNSETTLED = 5


@dataclass(frozen=True, eq=False)
class DissipationBatch:
    """Friction work of one steady cycle of each member, arrays of the broadcast shape [energy per unit thickness].

    Attributes
    ----------
    value : forward and reverse slip together; NaN where `reason` is not 0
    forward, reverse : the two parts
    permanent_stick_load : P_T
    reason : `Reason` of each member: 0 none, 1 gross sliding, 2 separation, 3 a value that is not finite or not admitted (P0 > 0,
        the rest of the loads >= 0, parameters by the rules of the profile), 4 the profile ends before the contact does,
        5 the quadrature did not converge
    notes : what holds for all members and must not be missed: the coupling of unlike materials, which is neglected
    """

    value: Array
    forward: Array
    reverse: Array
    permanent_stick_load: Array
    reason: NDArray[np.int8]
    notes: tuple[str, ...] = field(default=(), kw_only=True)


@dataclass(frozen=True, eq=False)
class PeakBatch:
    """Largest pointwise friction work of one steady cycle of each member, arrays of the broadcast shape.

    Attributes
    ----------
    value : max W(x) [energy per area], the largest of all maxima; NaN where `reason` is not 0, 0 where nothing slips
    place : |x| of the peak [length]; NaN where nothing slips
    fraction : the same between the permanent stick edge (0) and the largest contact (1)
    reason, notes : as in `DissipationBatch`
    second_value, second_place : the second largest maximum of W(x), where W falls by more than 1e-3 of the peak between the two;
        NaN where there is one maximum only
    value_error : error of `value` from above [energy per area]: by quadrature, by round-off and by the search
    """

    value: Array
    place: Array
    fraction: Array
    reason: NDArray[np.int8]
    second_value: Array
    second_place: Array
    value_error: Array
    notes: tuple[str, ...] = field(default=(), kw_only=True)


def dissipation(
    *,
    profile: Profile | Mapping[str, Any],
    material: Materials | Elastic,
    friction_coefficient: ArrayLike,
    mean_normal_load: ArrayLike,
    normal_amplitude: ArrayLike,
    tangential_amplitude: ArrayLike,
    phase: ArrayLike = math.pi / 2,
    mean_tangential_load: ArrayLike = 0.0,
) -> DissipationBatch:
    """Steady dissipation of ellipses P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase), every argument an array that broadcasts.

    Parameters
    ----------
    profile : any profile, or its keys with numbers or arrays: {"kind": "flat_rounded", "radius": ..., "flat_half_length": ...};
        the rises of a polynomial are a list of numbers or arrays. Tables and functions have no keys that could be arrays
    material : of the two bodies, or one for both
    friction_coefficient : f
    mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude : P0, P1, Q0, Q1 [force per unit thickness]
    phase : lag of Q behind P [radians], any sense

    Returns
    -------
    DissipationBatch. A member that is inadmissible gets NaN and a reason; the others get their values. Each is exact to 1e-11 of
    A f^2 P0^2 or 1e-10 relative, from slips of 1e-9 to gross sliding itself. Q0 decides on gross sliding only. Hertz and power laws
    take some 0.4 us a member, flat and rounded 1.5 us. The other profiles are integrated over the contact, from corner to corner:
    20 to 40 us for polynomials, wedges, compound curvatures and functions, 0.2 ms for tables of 31 rows, and 1 ms and more where
    P - P_c stays below 1e-5 of P0. Where the parameters are arrays each different polynomial or R2/R1 costs 1 to 3 ms.

    Raises
    ------
    InputError
        For a mapping of a kind whose parameters cannot vary, and for shapes that do not broadcast.

    >>> from scenes import Elastic, Hertz
    >>> steel = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    >>> batch = dissipation(
    ...     profile=Hertz(radius=1.0),
    ...     material=Materials(upper=steel, lower=steel),
    ...     friction_coefficient=1.0,
    ...     mean_normal_load=3.0,
    ...     normal_amplitude=1.0,
    ...     mean_tangential_load=1.1,
    ...     tangential_amplitude=[1.0, 5.0],
    ... )
    >>> [round(value, 12) for value in batch.value.tolist()], batch.reason.tolist()
    ([0.260168505754, nan], [0, 1])
    """
    loads = (mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude, phase, friction_coefficient)

    def works(block: Block) -> Array:
        found = np.empty((4, len(block.mirrored)))
        if block.kind in ("hertz", "power_law"):
            found[1:3] = works_by_lam(block.ellipses, quick_bracket, careful_bracket, _DEEP)
            found[1:3] /= block.parameters[0] if block.kind == "power_law" else 2
        elif block.kind == "flat_rounded":
            found[1:3] = _works_on_table(block.ellipses, block.modulus * _UNITS[block.kind](*block.parameters)[1])
        else:
            for members, contact, loops, unit, _ in block.groups():
                found[1:3, members] = dissipation_of(loops, contact) * unit * unit
        found[0], found[3] = found[1] + found[2], block.ellipses.permanent
        found[1:3] = np.where(block.mirrored, found[2:0:-1], found[1:3])
        return found

    material = _of_both(material)
    (value, forward, reverse, stick), reason = _columns(profile, material, loads, works, 4)
    return DissipationBatch(value, forward, reverse, stick, reason, notes=tuple(neglected_coupling(material)))


def peak_dissipation(
    *,
    profile: Profile | Mapping[str, Any],
    material: Materials | Elastic,
    friction_coefficient: ArrayLike,
    mean_normal_load: ArrayLike,
    normal_amplitude: ArrayLike,
    tangential_amplitude: ArrayLike,
    phase: ArrayLike = math.pi / 2,
    mean_tangential_load: ArrayLike = 0.0,
) -> PeakBatch:
    """Largest pointwise dissipation of the same ellipses, and where it is; arguments as in `dissipation`.

    W(x) may have two maxima: the shoulder, just inside the contact half-width a(P_min) of the least load, and one further out. Each
    piece between the kinks of W(x) is searched, which are at a(P_min) and at the corners of the profile. The value is good to some
    1e-10 of itself, or to `value_error` where slip is tiny. A member takes 3 ms for Hertz, 10 to 15 ms for power laws, flat and
    rounded, 20 ms for polynomials, wedges and compound curvatures, 0.1 s for tables of 31 rows.

    >>> from scenes import Elastic, Hertz
    >>> steel = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    >>> batch = peak_dissipation(
    ...     profile=Hertz(radius=1.0),
    ...     material=Materials(upper=steel, lower=steel),
    ...     friction_coefficient=1.0,
    ...     mean_normal_load=3.0,
    ...     normal_amplitude=1.0,
    ...     tangential_amplitude=1.0,
    ... )
    >>> round(float(batch.fraction), 3)  # the paper: "just over 60 %"
    0.595
    """
    loads = (mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude, phase, friction_coefficient)

    def maxima(block: Block) -> Array:
        found = np.empty((6, len(block.mirrored)))
        for members, contact, loops, unit, length in block.groups():
            found[:, members] = maxima_of(loops, contact)
            found[:3, members] *= unit / length * unit
            found[3:5, members] *= length
        return found

    material = _of_both(material)
    (value, second, error, place, second_place, fraction), reason = _columns(profile, material, loads, maxima, 6)
    notes = tuple(neglected_coupling(material))
    return PeakBatch(value, place, fraction, reason, second, second_place, error, notes=notes)


def _works_on_table(e: Ellipses, unit: Array) -> Array:
    """Forward and reverse part of W pi E*/(2 f^2), (2, m), on flat and rounded faces whose unit of load is E* b^2/R, (m,)."""
    e = e.over(unit)
    # Whole eights of octaves, so that the next block or call finds its table; what is 2^-40 of the largest load counts for nothing.
    most = float(np.max(e.mean + e.amplitude))
    first, last = (math.frexp(load)[1] - 1 for load in (max(float(np.min(e.permanent)), 2.0**-40 * most), most))
    table = _table(first // 8 * 8, last // 8 * 8 + 7)
    return np.array(works_by_lam(e, table.quick, table.careful, _DEEP_ON_TABLE)) * unit * unit


@lru_cache(maxsize=8)
def _table(first: int, last: int) -> LamTable:
    return LamTable(_contact("flat_rounded", ()), first, last)


# ------------------------------------------------------------------------------------------- members and their reasons
@dataclass(frozen=True, eq=False)
class Block:
    """The good members of one block.

    Attributes
    ----------
    kind : of their profiles
    parameters : (m,) each, in the order of `_KEYS`; none for a table, a function or a whole polynomial
    whole : the contact of a profile that is given as such; None where its parameters may vary
    modulus : E*
    ellipses : their loops
    mirrored : (m,) whether Q goes round the other way
    """

    kind: str
    parameters: list[Array]
    whole: Contact | None
    modulus: float
    ellipses: Ellipses
    mirrored: NDArray[np.bool_]

    def groups(self) -> Iterator[tuple[Indices, Contact, Ellipses, Array | float, Array | float]]:
        """Members whose profiles differ by units only: their contact and loops in these; the units of load and of length."""
        if self.whole is not None:
            yield np.arange(len(self.mirrored)), self.whole, self.ellipses, 1.0, 1.0
            return
        for members, shape, length, height in _alike(self.kind, self.parameters):
            unit = self.modulus * height
            yield members, _contact(self.kind, shape), self.ellipses.take(members).over(unit), unit, length


def _of_both(material: Materials | Elastic) -> Materials:
    return Materials(upper=material, lower=material) if isinstance(material, Elastic) else material


def _columns(
    profile: Profile | Mapping[str, Any],
    material: Materials,
    loads: tuple[ArrayLike, ...],
    results_of: Callable[[Block], Array],
    count: int,
) -> tuple[list[Array], NDArray[np.int8]]:
    """`count` results of each member, NaN where there are none, and its reason, in the broadcast shape and read-only.

    `results_of` a block are (count, m), the first three over 2 f^2/(pi E*); the first one must be finite.

    Raises
    ------
    InputError
        For a profile or material that does not pass its own check, for keys that are no profile's, for what is no number, and for
        shapes that do not broadcast.
    """
    material = validated(material, Materials)
    profile = validated(profile, Frozen) if isinstance(profile, Frozen) else profile
    kind, given = _parameters_of(profile)
    try:
        arrays = [np.asarray(value, dtype=float) for value in (*loads, *given.values())]
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except (TypeError, ValueError) as reason:
        raise InputError(f"the arrays of a batch must broadcast, and be of numbers: {reason}") from reason
    modulus, most, whole = composite_modulus(material), math.inf, None
    if not isinstance(profile, Mapping):
        whole = contact_of(profile, material)
        if kind in ("tabulated", "callable"):
            end = profile.extent if kind == "callable" else profile.spline().x[-1]  # type: ignore[union-attr]
            most = float(whole.load(end)) * (1 - 1e-12)
    total = math.prod(shape)
    found, reasons = np.full((count, total), np.nan), np.zeros(total, dtype=np.int8)
    for first in range(0, total, _BLOCK):
        last = min(first + _BLOCK, total)
        parts = [_part(array, shape, first, last) for array in arrays]
        invalid = _invalid(*parts[: len(loads)])
        if whole is None:
            invalid |= _invalid_shapes(kind, parts[len(loads) :])
        if np.any(invalid):
            parts = [np.where(invalid, 1.0, part) for part in parts]
        mean, amplitude, force, tangential, phase, friction = parts[: len(loads)]
        # Without friction only Q = 0 is admissible, and nothing is dissipated: any positive coefficient gives that.
        some_friction = np.where(friction > 0, friction, 1.0)
        with np.errstate(over="ignore", invalid="ignore"):
            # Q1/f beyond all bounds slides.
            loops = ellipses_of(mean, amplitude, tangential, phase, some_friction)
        mirrored = np.tan(phase / 2) < 0
        code = _reasons(loops, np.where(mirrored, -force, force), tangential, friction)
        code[(code == Reason.NONE) & (mean + amplitude > most)] = Reason.EXTENT
        code[invalid] = Reason.INVALID
        good = np.flatnonzero(code == Reason.NONE)
        if len(good):
            if len(good) < len(code):
                loops, mirrored, some_friction = loops.take(good), mirrored[good], some_friction[good]
                parts = [part[good] for part in parts]
            results = results_of(Block(kind, parts[len(loads) :], whole, modulus, loops, mirrored))
            results[:3] *= 2 / (math.pi * modulus) * some_friction**2
            found[:, first + good] = results
            code[good[~np.isfinite(results[0])]] = Reason.UNSETTLED
        reasons[first:last] = code
    for array in (found, reasons):
        array.flags.writeable = False
    return [column.reshape(shape) for column in found], reasons.reshape(shape)


def _part(array: Array, shape: tuple[int, ...], first: int, last: int) -> Array:
    """Members `first` to `last` of the array broadcast to `shape`, without the others."""
    if array.size == 1:
        return np.full(last - first, array.item())
    if array.shape == shape and array.flags.c_contiguous:
        return array.reshape(-1)[first:last]
    return np.broadcast_to(array, shape).flat[first:last]


def _invalid(mean: Array, amplitude: Array, force: Array, tangential: Array, phase: Array, friction: Array) -> NDArray[np.bool_]:
    """Members (m,) with values that are not finite, or negative where they must not be."""
    finite = np.logical_and.reduce([np.isfinite(values) for values in (mean, amplitude, force, tangential, phase, friction)])
    return np.asarray(~finite | (mean <= 0) | (amplitude < 0) | (tangential < 0) | (friction < 0))


def _reasons(e: Ellipses, force: Array, tangential: Array, friction: Array) -> NDArray[np.int8]:
    """Reason of each valid member (m,): separation, gross sliding; |Q| = f P is admitted, to rounding. `force`: Q0 as turned."""
    limit = friction * e.mean
    slack = 4e-16 * (np.abs(force) + tangential + limit + friction * e.amplitude)
    # The greatest Q - f P and -Q - f P; without friction u and v are those of another coefficient.
    slides = np.maximum(friction * e.u + force, friction * e.v - force) > limit + slack
    slides |= (friction == 0) & (tangential > 0)
    return np.where(e.amplitude > e.mean, Reason.SEPARATION, np.where(slides, Reason.SLIDING, Reason.NONE)).astype(np.int8)


# ------------------------------------------------------------------------------------------- profiles whose parameters vary
_KEYS = {
    "hertz": ("radius",),
    "flat_rounded": ("radius", "flat_half_length"),
    "power_law": ("exponent", "length", "rise"),
    "compound": ("inner_radius", "outer_radius", "inner_half_length"),
    "wedge": ("tip_radius", "tip_half_length"),
    "polynomial": ("length", "rises"),
}


def _units_of_polynomial(length: Array, *rises: Array) -> tuple[Array, ...]:
    largest = np.max(np.abs(rises), axis=0)
    return length, largest, *(rise / largest for rise in rises)


# Units of length and of height of profiles with these parameters, and the shape that they leave.
_UNITS: dict[str, Callable[..., tuple[Array, ...]]] = {
    "hertz": lambda radius: (np.sqrt(radius), np.ones_like(radius)),
    "flat_rounded": lambda radius, b: (b, b * b / radius),
    "power_law": lambda exponent, length, rise: (length, rise, exponent),
    "compound": lambda inner, outer, b: (b, b * b / inner, outer / inner),
    "wedge": lambda radius, b: (b, b * b / radius),
    "polynomial": _units_of_polynomial,
}
# The profiles of these shapes.
_PROFILES: dict[str, Callable[..., Profile]] = {
    "hertz": lambda: Hertz(radius=1.0),
    "flat_rounded": lambda: FlatRounded(radius=1.0, flat_half_length=1.0),
    "power_law": lambda exponent: PowerLaw(exponent=exponent, length=1.0, rise=1.0),
    "compound": lambda ratio: Compound(inner_radius=1.0, outer_radius=ratio, inner_half_length=1.0),
    "wedge": lambda: Wedge(tip_radius=1.0, tip_half_length=1.0),
    "polynomial": lambda *rises: EvenPolynomial(length=1.0, rises=rises),
}


def _parameters_of(profile: Profile | Mapping[str, Any]) -> tuple[str, dict[str, ArrayLike]]:
    """The kind of a profile or mapping, and its numbers or arrays, those of `rises` one by one; none of a table or a function.

    Raises
    ------
    InputError
        For a kind whose parameters cannot vary, for a key too many or too few.
    """
    if not isinstance(profile, Mapping):
        return profile.kind, {name: getattr(profile, name) for name in _KEYS.get(profile.kind, ()) if name != "rises"}
    kind, given = profile.get("kind"), {name: value for name, value in profile.items() if name != "kind"}
    if kind not in _KEYS:
        raise InputError(
            f"profile: a mapping for a batch has one of the kinds {', '.join(_KEYS)}, not {kind!r}; give the profile itself"
        )
    if set(given) != set(_KEYS[kind]):
        raise InputError(f"profile: {kind} comes with all its keys, {', '.join(_KEYS[kind])}, not {', '.join(given) or 'none'}")
    given = {name: given[name] for name in _KEYS[kind]}
    rises = given.pop("rises", (0.0,))
    if not isinstance(rises, list | tuple) or not len(rises):
        raise InputError("profile: rises is a list of numbers or arrays, one for each of the powers 2, 4, 6, ...")
    return kind, given | ({f"rise {number}": value for number, value in enumerate(rises, 1)} if kind == "polynomial" else {})


def _alike(kind: str, parameters: list[Array]) -> Iterator[tuple[Indices, tuple[float, ...], Array, Array]]:
    """Members (k,) whose profiles are the same in units of their own: that shape, and units of length and height, (k,) each."""
    with np.errstate(all="ignore"):
        length, height, *shape = _UNITS[kind](*parameters)
    if all(np.all(values == values[0]) for values in shape):
        yield np.arange(len(length)), tuple(float(values[0]) for values in shape), length, height
        return
    rows, fold = np.unique(np.stack(shape, axis=1), axis=0, return_inverse=True)
    order = np.argsort(fold.reshape(-1), kind="stable")
    ends = np.cumsum(np.bincount(fold.reshape(-1), minlength=len(rows)))
    for row, members in zip(rows.tolist(), np.split(order, ends[:-1]), strict=True):
        yield members, tuple(row), length[members], height[members]


@lru_cache(maxsize=64)
def _contact(kind: str, shape: tuple[float, ...]) -> Contact:
    """The contact of a profile in units of its own, with E* = 1."""
    return contact_of(_PROFILES[kind](*shape), Materials(upper=_HALF, lower=_HALF))


def _invalid_shapes(kind: str, parameters: list[Array]) -> NDArray[np.bool_]:
    """Members (m,) whose parameters their kind of profile does not admit."""
    least = {"power_law": (1.0, _LEAST, _LEAST), "polynomial": (_LEAST, *[-np.inf] * (len(parameters) - 1))}
    bounds = least.get(kind, (_LEAST,) * len(parameters))
    wrong = ~np.logical_and.reduce([np.isfinite(one) & (one >= bound) for one, bound in zip(parameters, bounds, strict=True)])
    if kind in ("polynomial", "compound"):
        # By the rules of the profile, and by those of one contact.
        some = np.flatnonzero(~wrong)
        for members, shape, *_ in _alike(kind, [values[some] for values in parameters]) if len(some) else ():
            try:
                _contact(kind, shape)
            except (ValidationError, InputError):
                wrong[some[members]] = True
    return wrong
