"""What a batch is asked, block by block: arguments broadcast, bad members told apart by a reason, contacts and loops of the others.

Memory beyond arguments and results is that of one block, however many members there are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError, Materials, Profile
from scenes.frozen import Frozen, validated
from semi_analytic.batch import Reason
from semi_analytic.batch_ellipses import Ellipses, ellipses_of
from semi_analytic.batch_profiles import Profiles, invalid_parameters, largest_load, parameters_of, profiles_of
from semi_analytic.elasticity import composite_modulus

Array = NDArray[np.float64]

_BLOCK = 16384


@dataclass(frozen=True, eq=False)
class Block:
    """Members from number `first` on.

    Attributes
    ----------
    first : number of the first, all counted in the order of memory of the broadcast shape
    reason : (n,) `Reason` of each
    good : (m,) numbers, counted from `first`, of those without one
    ellipses, profiles : of the good ones
    scale : (m,) 2 f^2/(pi E*)
    mirrored : (m,) whether Q goes round the other way
    """

    first: int
    reason: NDArray[np.int8]
    good: NDArray[np.intp]
    ellipses: Ellipses
    profiles: Profiles
    scale: Array
    mirrored: NDArray[np.bool_]

    @property
    def all(self) -> slice:
        """Places of all members."""
        return slice(self.first, self.first + len(self.reason))

    @property
    def places(self) -> NDArray[np.intp] | slice:
        """Places of the good ones."""
        return self.all if len(self.good) == len(self.reason) else self.first + self.good


@dataclass(frozen=True, eq=False)
class Batch:
    """The whole question; `loads` are P0, P1, Q0, Q1, phase and f, and `parameters` those of the profile."""

    profile: Profile | Mapping[str, Any]
    material: Materials
    shape: tuple[int, ...]
    loads: tuple[Array, ...]
    parameters: Mapping[str, Array]

    def blocks(self) -> Iterator[Block]:
        """All of them, in order."""
        whole = None if isinstance(self.profile, Mapping) else profiles_of(self.profile, self.material, {})
        most = math.inf if whole is None else largest_load(whole.of(slice(None)))
        count = math.prod(self.shape)
        for first in range(0, count, _BLOCK):
            yield self._block(first, min(first + _BLOCK, count), whole, most)

    def _block(self, first: int, last: int, whole: Profiles | None, most: float) -> Block:
        loads = [_piece(values, self.shape, first, last) for values in self.loads]
        parameters = {name: _piece(values, self.shape, first, last) for name, values in self.parameters.items()}
        invalid = _invalid(*loads) | invalid_parameters(self.profile, parameters, last - first)
        if np.any(invalid):
            loads = [np.where(invalid, 1.0, values) for values in loads]
        mean, amplitude, force, tangential, phase, friction = loads
        # Without friction only Q = 0 is admissible, and nothing is dissipated: any positive coefficient gives that.
        some_friction = np.where(friction > 0, friction, 1.0)
        with np.errstate(over="ignore", invalid="ignore"):
            # Q1/f beyond all bounds slides.
            loops = ellipses_of(mean, amplitude, tangential, phase, some_friction)
        mirrored = np.tan(phase / 2) < 0
        code = _reasons(loops, np.where(mirrored, -force, force), tangential, friction)
        code[(code == Reason.NONE) & (mean + amplitude > most * (1 - 1e-12))] = Reason.EXTENT
        code[invalid] = Reason.INVALID
        good = np.flatnonzero(code == Reason.NONE)
        some = whole or profiles_of(self.profile, self.material, {name: values[good] for name, values in parameters.items()})
        scale = 2 / (math.pi * composite_modulus(self.material)) * some_friction[good] ** 2
        loops = loops if len(good) == len(code) else loops.take(good)
        return Block(first, code, good, loops, some, scale, mirrored[good])


def batch_of(profile: Profile | Mapping[str, Any], material: Materials, loads: tuple[ArrayLike, ...]) -> Batch:
    """The question, checked as a whole: its keys, and that its arrays broadcast.

    Raises
    ------
    InputError
        For a profile or material that does not pass its own check, for keys that are no profile's, for what is no number, and for
        shapes that do not broadcast.
    """
    material = validated(material, Materials)
    profile = validated(profile, Frozen) if isinstance(profile, Frozen) else profile
    given = parameters_of(profile)
    try:
        arrays = [np.asarray(value, dtype=float) for value in (*loads, *given.values())]
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except (TypeError, ValueError) as reason:
        raise InputError(f"the arrays of a batch must broadcast, and be of numbers: {reason}") from reason
    columns = tuple(arrays[: len(loads)])
    return Batch(profile, material, shape, columns, dict(zip(given, arrays[len(loads) :], strict=True)))


def _piece(array: Array, shape: tuple[int, ...], first: int, last: int) -> Array:
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
