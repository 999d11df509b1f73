"""Dissipation and its peak for arrays of ellipses: the two calls that sweeps and the paper's figures 7 and 10 need."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError, Materials, Profile, freeze
from semi_analytic.batch import Ellipses, Reason, broadcast, dissipation_of, ellipses_of, reasons
from semi_analytic.batch_density import peak_of
from semi_analytic.contact import Contact, contact_of
from semi_analytic.corners import has_corners
from semi_analytic.elasticity import composite_modulus
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.hertz import HertzContact

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DissipationBatch:
    """Friction work of one steady cycle of each member, arrays of the broadcast shape [energy per unit thickness].

    Attributes
    ----------
    value : forward and reverse slip together; NaN where `reason` is not 0
    forward, reverse : the two parts
    permanent_stick_load : P_T
    reason : `Reason` of each member: 0 none, 1 gross sliding, 2 separation, 3 a value that is negative or not finite
    """

    value: Array
    forward: Array
    reverse: Array
    permanent_stick_load: Array
    reason: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class PeakBatch:
    """Largest pointwise friction work of one steady cycle of each member, arrays of the broadcast shape.

    Attributes
    ----------
    value : max W(x) [energy per area]; NaN where `reason` is not 0, 0 where nothing slips
    place : |x| of the peak [length]; NaN where nothing slips
    fraction : the same between the permanent stick edge (0) and the largest contact (1)
    reason : as in `DissipationBatch`
    """

    value: Array
    place: Array
    fraction: Array
    reason: NDArray[np.int8]


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
    profile : a profile, or its keys with numbers or arrays: {"kind": "flat_rounded", "radius": ..., "flat_half_length": ...}
    material : both bodies
    friction_coefficient : f
    mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude : P0, P1, Q0, Q1 [force per unit thickness]
    phase : lag of Q behind P [radians], any sense

    Returns
    -------
    DissipationBatch. A member that is inadmissible gets NaN and a reason; the others get their values. Each is exact to 1e-11 of
    A f^2 P0^2 or 1e-10 relative, from slips of 1e-9 to 1e-12 from gross sliding. Q0 decides on gross sliding only.

    Raises
    ------
    InputError
        For a profile that has no batch, and for shapes that do not broadcast.

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
    members = _members(
        profile,
        material,
        friction_coefficient,
        mean_normal_load,
        normal_amplitude,
        mean_tangential_load,
        tangential_amplitude,
        phase,
    )
    forward, reverse, stick = (np.full(len(members.reason), np.nan) for _ in range(3))
    good = members.good
    if len(good):
        parts = dissipation_of(members.ellipses, members.contact)
        forward[good], reverse[good] = (members.scale * np.where(members.mirrored, *pair) for pair in (parts[::-1], parts))
        stick[good] = members.ellipses.permanent[:, 0]
    value, forward, reverse, stick = (freeze(part.reshape(members.shape)) for part in (forward + reverse, forward, reverse, stick))
    return DissipationBatch(value, forward, reverse, stick, freeze(members.reason.reshape(members.shape), np.int8))


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
    members = _members(
        profile,
        material,
        friction_coefficient,
        mean_normal_load,
        normal_amplitude,
        mean_tangential_load,
        tangential_amplitude,
        phase,
    )
    value, place, fraction = (np.full(len(members.reason), np.nan) for _ in range(3))
    good = members.good
    if len(good):
        top, x = peak_of(members.ellipses, members.contact)
        inner = members.contact.half_width(members.ellipses.permanent)[:, 0]
        outer = members.contact.half_width(members.ellipses.mean + members.ellipses.amplitude)[:, 0]
        slips = top > 0
        value[good] = members.scale * top
        place[good] = np.where(slips, x, np.nan)
        fraction[good] = np.where(slips, (x - inner) / np.where(slips, outer - inner, 1.0), np.nan)
    value, place, fraction = (freeze(part.reshape(members.shape)) for part in (value, place, fraction))
    return PeakBatch(value, place, fraction, freeze(members.reason.reshape(members.shape), np.int8))


@dataclass(frozen=True, eq=False)
class _Members:
    """Broadcast members: all their reasons, and the loops, contacts and scales of the admissible ones."""

    shape: tuple[int, ...]
    reason: NDArray[np.int8]
    good: NDArray[np.intp]
    ellipses: Ellipses
    contact: Contact
    scale: Array
    mirrored: NDArray[np.bool_]


def _members(profile: Profile | Mapping[str, Any], material: Materials, *loads: ArrayLike) -> _Members:
    parameters = dict(profile) if isinstance(profile, Mapping) else {}
    arrays = {name: value for name, value in parameters.items() if name != "kind"}
    try:
        shape, flat = broadcast(*loads, *arrays.values())
    except ValueError as reason:
        raise InputError(f"the arrays of a batch must broadcast: {reason}") from reason
    friction, mean, amplitude, mean_force, tangential, phase = flat[:6]
    code = reasons(mean, amplitude, mean_force, tangential, phase, friction)
    # Without friction only Q = 0 is admissible, and nothing is dissipated: any positive coefficient gives that.
    friction = np.where(friction > 0, friction, 1.0)
    good = np.flatnonzero(code == Reason.NONE)
    columns = (values[good] for values in (mean, amplitude, tangential, phase, friction))
    contact = _contact(profile, material, {name: values[good, None] for name, values in zip(arrays, flat[6:], strict=True)})
    scale = 2 / (math.pi * composite_modulus(material)) * friction[good] ** 2
    return _Members(shape, code, good, ellipses_of(*columns), contact, scale, np.sin(phase[good]) < 0)


def _contact(profile: Profile | Mapping[str, Any], material: Materials, arrays: Mapping[str, Any]) -> Contact:
    """The contact of a profile, or of a mapping whose numbers may be arrays (m, 1)."""
    if not isinstance(profile, Mapping):
        contact = contact_of(profile, material)
        if has_corners(contact):
            # The batch rule takes P(a) for smooth between the turning points; across a corner it was 1e-4 off.
            raise InputError(f"profile: a batch takes no profile with corners, as {profile.kind} has; solve the scenes one by one")
        return contact
    modulus = composite_modulus(material)
    keys = {"hertz": {"radius"}, "flat_rounded": {"radius", "flat_half_length"}}
    kind = profile.get("kind")
    if kind not in keys or set(arrays) != keys[kind]:
        raise InputError(f"profile: a mapping for a batch is one of {', '.join(keys)} with all its keys, not {sorted(profile)}")
    if any(not np.all(np.isfinite(values)) or np.any(values <= 0) for values in arrays.values()):
        raise InputError(f"profile: {', '.join(arrays)} must be positive")
    if kind == "hertz":
        return HertzContact(modulus, datum_length=arrays["radius"], **arrays)
    return FlatRoundedContact(modulus, datum_length=arrays["radius"], **arrays)
