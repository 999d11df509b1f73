"""Profiles of a batch: one for all members, or a kind whose parameters are arrays.

Vectorised, one call for all: hertz, flat_rounded, power_law, compound, wedge. An even polynomial with arrays among its rises is
solved set of rises by set of rises. Tables and functions have no parameters to vary: give the profile itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ValidationError

from scenes import Compound, EvenPolynomial, FlatRounded, InputError, Materials, PowerLaw, Profile, Wedge
from semi_analytic.batch_compound import CompoundContacts
from semi_analytic.contact import contact_of
from semi_analytic.elasticity import composite_modulus
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.hertz import HertzContact
from semi_analytic.polynomial import PolynomialContact
from semi_analytic.power_law import PowerLawContact

Array = NDArray[np.float64]

_LEAST = float(np.finfo(float).tiny)
_KEYS = {
    "hertz": ("radius",),
    "flat_rounded": ("radius", "flat_half_length"),
    "power_law": ("exponent", "length", "rise"),
    "compound": ("inner_radius", "outer_radius", "inner_half_length"),
    "wedge": ("tip_radius", "tip_half_length"),
    "polynomial": ("length", "rises"),
}


class BatchContact(Protocol):
    """What batches ask of a `Contact`."""

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]."""

    def load(self, half_width: ArrayLike) -> Array:
        """P(a)."""

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress]."""

    def reach(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) from eta and P_x - eta >= 0."""

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) from P and P - P_c."""


@dataclass(frozen=True, eq=False)
class Profiles:
    """The contacts of m members.

    Attributes
    ----------
    make : a contact from keyword parameters
    parameters : (m,) each; none for one contact that serves all
    alike : names of those that must be the same number in one call of `make`
    """

    make: Callable[..., BatchContact]
    parameters: Mapping[str, Array] = field(default_factory=dict)
    alike: tuple[str, ...] = ()

    @classmethod
    def of_one(cls, contact: BatchContact) -> Profiles:
        """The same contact for all."""
        return cls(lambda: contact)

    def of(self, members: Any) -> BatchContact:
        """The contact of some members; its parameters take the shape of the index."""
        return self.make(**{name: values[members] for name, values in self.parameters.items()})

    def take(self, members: NDArray[np.intp]) -> Profiles:
        """Those of some members."""
        return Profiles(self.make, {name: values[members] for name, values in self.parameters.items()}, self.alike)

    def groups(self, count: int, alike: tuple[str, ...] | None = None) -> Iterator[tuple[NDArray[np.intp], Profiles]]:
        """Members (of `count`) whose parameters `alike` are the same, and their profiles with these as plain numbers."""
        names = self.alike if alike is None else tuple(name for name in alike if name in self.parameters)
        if not names:
            yield np.arange(count), self
            return
        rows, fold = np.unique(np.stack([self.parameters[name] for name in names], axis=1), axis=0, return_inverse=True)
        order = np.argsort(fold.reshape(-1), kind="stable")
        ends = np.cumsum(np.bincount(fold.reshape(-1), minlength=len(rows)))
        for row, members in zip(rows.tolist(), np.split(order, ends[:-1]), strict=True):
            rest = {name: values[members] for name, values in self.parameters.items() if name not in names}
            yield members, Profiles(partial(self.make, **dict(zip(names, row, strict=True))), rest)


def parameters_of(profile: Profile | Mapping[str, Any]) -> dict[str, ArrayLike]:
    """The numbers or arrays of a mapping, those of `rises` one by one; none of a profile that is given as such.

    Raises
    ------
    InputError
        For a kind whose parameters cannot vary, for a key too many or too few.
    """
    if not isinstance(profile, Mapping):
        return {}
    kind, given = profile.get("kind"), {name: value for name, value in profile.items() if name != "kind"}
    if kind not in _KEYS:
        raise InputError(
            f"profile: a mapping for a batch has one of the kinds {', '.join(_KEYS)}, not {kind!r}; give the profile itself"
        )
    if set(given) != set(_KEYS[kind]):
        raise InputError(f"profile: {kind} comes with all its keys, {', '.join(_KEYS[kind])}, not {', '.join(given) or 'none'}")
    if kind != "polynomial":
        return given
    rises = given.pop("rises")
    if not isinstance(rises, list | tuple) or not len(rises):
        raise InputError("profile: rises is a list of numbers or arrays, one for each of the powers 2, 4, 6, ...")
    return given | {f"rise {number}": value for number, value in enumerate(rises, 1)}


def profiles_of(profile: Profile | Mapping[str, Any], material: Materials, arrays: Mapping[str, Array]) -> Profiles:
    """The contacts of members with admissible parameters `arrays`, (m,) each, as named by `parameters_of`."""
    modulus = composite_modulus(material)
    match profile:
        case Compound():
            return Profiles.of_one(CompoundContacts(modulus, profile.inner_radius, profile.outer_radius, profile.inner_half_length))
        case Wedge():
            return Profiles.of_one(CompoundContacts(modulus, profile.tip_radius, math.inf, profile.tip_half_length))
        case FlatRounded():
            return Profiles.of_one(FlatRoundedContact(modulus, profile.radius, profile.flat_half_length, profile.datum_length))
        case PowerLaw():
            contact = PowerLawContact(modulus, profile.exponent, profile.length, profile.rise, profile.datum_length)
            return Profiles.of_one(contact)
    if not isinstance(profile, Mapping):
        return Profiles.of_one(contact_of(profile, material))
    match profile["kind"]:
        case "hertz":
            return Profiles(partial(_hertz, modulus), arrays)
        case "flat_rounded":
            return Profiles(partial(_flat_rounded, modulus), arrays)
        case "power_law":
            return Profiles(partial(_power_law, modulus), arrays)
        case "compound":
            return Profiles(partial(CompoundContacts, modulus), arrays)
        case "wedge":
            return Profiles(partial(_wedge, modulus), arrays)
    return Profiles(partial(_polynomial, modulus), arrays, tuple(arrays))


def invalid_parameters(profile: Profile | Mapping[str, Any], arrays: Mapping[str, Array], count: int) -> NDArray[np.bool_]:
    """Which members (m,) have parameters that their kind of profile does not admit."""
    wrong = np.zeros(count, dtype=bool)
    if not isinstance(profile, Mapping):
        return wrong
    if profile["kind"] == "polynomial":
        return _invalid_polynomials(arrays)
    for name, values in arrays.items():
        wrong |= ~(np.isfinite(values) & (values >= (1 if name == "exponent" else _LEAST)))
    return wrong


def _invalid_polynomials(arrays: Mapping[str, Array]) -> NDArray[np.bool_]:
    """By the rules of the profile, and by those of one contact."""
    wrong = ~np.all(np.isfinite(np.stack(list(arrays.values()))), axis=0)
    finite = np.flatnonzero(~wrong)
    every = Profiles(_checked_polynomial, arrays, tuple(arrays)).take(finite)
    for members, some in every.groups(len(finite)):
        try:
            some.of(members)
        except (ValidationError, InputError):
            wrong[finite[members]] = True
    return wrong


def _checked_polynomial(length: float, **rises: float) -> BatchContact:
    profile = EvenPolynomial(length=length, rises=tuple(rises.values()))
    return PolynomialContact(1.0, 1.0, profile.length, profile.rises)


def _hertz(modulus: float, radius: Any) -> BatchContact:
    return HertzContact(modulus, radius, radius)


def _flat_rounded(modulus: float, radius: Any, flat_half_length: Any) -> BatchContact:
    return FlatRoundedContact(modulus, radius, flat_half_length, radius)


def _power_law(modulus: float, exponent: Any, length: Any, rise: Any) -> BatchContact:
    return PowerLawContact(modulus, exponent, length, rise, length)


def _wedge(modulus: float, tip_radius: Any, tip_half_length: Any) -> BatchContact:
    return CompoundContacts(modulus, tip_radius, math.inf, tip_half_length)


def _polynomial(modulus: float, length: float, **rises: float) -> BatchContact:
    return PolynomialContact(modulus, 1.0, length, tuple(rises.values()))


def largest_load(contact: BatchContact) -> float:
    """What a profile that ends somewhere can carry, a table or a function; infinite for the others."""
    end = getattr(contact, "extent", math.inf)
    return math.inf if math.isinf(end) else float(contact.load(end))
