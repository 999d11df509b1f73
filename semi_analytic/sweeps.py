"""Dissipation and its peak for arrays of ellipses: the two calls that sweeps and the paper's figures 7 and 10 need."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import Materials, Profile
from semi_analytic.batch import Reason, dissipation_of
from semi_analytic.batch_density import maxima_of
from semi_analytic.batch_members import Batch, Block, batch_of
from semi_analytic.bookkeeping import neglected_coupling

Array = NDArray[np.float64]


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
        5 the quadrature did not settle
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
    material: Materials,
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
    material : both bodies
    friction_coefficient : f
    mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude : P0, P1, Q0, Q1 [force per unit thickness]
    phase : lag of Q behind P [radians], any sense

    Returns
    -------
    DissipationBatch. A member that is inadmissible gets NaN and a reason; the others get their values. Each is exact to 1e-11 of
    A f^2 P0^2 or 1e-10 relative, from slips of 1e-9 to gross sliding itself. Q0 decides on gross sliding only. Hertz and power laws
    take some 0.4 us a member, flat and rounded 1.5 us. On the other profiles every phase of slip is cut at the corners and halved
    until it settles: 1 ms a member for compound curvatures, wedges and polynomials, 15 to 200 ms for functions and tables.

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
    batch = batch_of(profile, material, loads)
    value, forward, reverse, stick, reason = _columns(batch, 4)
    for block in batch.blocks():
        reason[block.all] = block.reason
        if not len(block.good):
            continue
        ahead, back = (block.scale * part for part in dissipation_of(block.ellipses, block.profiles))
        forward[block.places] = np.where(block.mirrored, back, ahead)
        reverse[block.places] = np.where(block.mirrored, ahead, back)
        value[block.places] = ahead + back
        stick[block.places] = block.ellipses.permanent
        _unsettled(value, reason, block)
    columns = (value, forward, reverse, stick, reason)
    return DissipationBatch(*(_frozen(part, batch) for part in columns), notes=tuple(neglected_coupling(material)))


def peak_dissipation(
    *,
    profile: Profile | Mapping[str, Any],
    material: Materials,
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
    1e-10 of itself, or to `value_error` where slip is tiny. A member takes 3 ms for Hertz, 10 ms for power laws, flat and rounded,
    50 to 130 ms for polynomials, wedges and compound curvatures, half a second for tables.

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
    batch = batch_of(profile, material, loads)
    value, place, fraction, second, second_place, error, reason = _columns(batch, 6)
    for block in batch.blocks():
        reason[block.all] = block.reason
        if not len(block.good):
            continue
        found = maxima_of(block.ellipses, block.profiles)
        for column, works in ((value, found.value), (second, found.second_value), (error, found.error)):
            column[block.places] = block.scale * works
        for column, values in ((place, found.place), (fraction, found.fraction), (second_place, found.second_place)):
            column[block.places] = values
        _unsettled(value, reason, block)
    columns = (value, place, fraction, reason, second, second_place, error)
    return PeakBatch(*(_frozen(part, batch) for part in columns), notes=tuple(neglected_coupling(material)))


def _columns(batch: Batch, count: int) -> list[NDArray[Any]]:
    """Room for results, NaN so far, and for reasons: (m,) each."""
    members = math.prod(batch.shape)
    return [*(np.full(members, np.nan) for _ in range(count)), np.zeros(members, dtype=np.int8)]


def _unsettled(value: Array, reason: NDArray[np.int8], block: Block) -> None:
    """A reason for those that should have a value and have none."""
    here = block.first + block.good
    reason[here[~np.isfinite(value[here])]] = Reason.UNSETTLED


def _frozen(column: NDArray[Any], batch: Batch) -> NDArray[Any]:
    """The results in their shape, read-only from now on."""
    array = column.reshape(batch.shape)
    array.flags.writeable = False
    return array
