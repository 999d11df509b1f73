"""What the tangential problem asks of a profile: normal contact as a pile of flat punches."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    PowerLaw,
    Profile,
    Tabulated,
    Wedge,
)
from semi_analytic.callable_profile import callable_contact
from semi_analytic.compound import CompoundContact
from semi_analytic.elasticity import composite_modulus
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.hertz import HertzContact
from semi_analytic.polynomial import PolynomialContact
from semi_analytic.power_law import PowerLawContact
from semi_analytic.tabulated import tabulated_contact
from semi_analytic.wedge import wedge_contact

Array = NDArray[np.float64]


class Contact(Protocol):
    """Normal contact of one symmetric profile between two given materials; arrays broadcast, loads are per unit thickness.

    # notation: a half-width, P or eta normal load, P_x load at which a = |x|, L datum length
    """

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]."""

    def load(self, half_width: ArrayLike) -> Array:
        """P(a), 0 below the least half-width."""

    def pressure(self, x: ArrayLike, load: ArrayLike) -> Array:
        """p(x, P) >= 0 [stress]."""

    def pressure_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int_0^P eta dp(x, eta)."""

    def spread(self, x: ArrayLike, load: ArrayLike) -> Array:
        """S(x, P) = int arccosh(|x|/a(eta)) d eta over eta < min(P, P_x)."""

    def spread_moment(self, x: ArrayLike, load: ArrayLike) -> Array:
        """int eta arccosh(|x|/a(eta)) d eta over eta < min(P, P_x)."""

    def reach(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """arccosh(|x|/a(eta)) from eta and P_x - eta >= 0."""

    def root_quotient(self, x: ArrayLike, excess: ArrayLike, load: ArrayLike) -> Array:
        """sqrt((eta - P_x)/(a(eta)^2 - x^2)) from eta and eta - P_x > 0."""

    def log_distance(self, load: ArrayLike) -> Array:
        """int_0^P ln(2 L/a(eta)) d eta."""

    def log_moment(self, load: ArrayLike) -> Array:
        """int_0^P eta ln(2 L/a(eta)) d eta."""

    def log_ratio(self, load: ArrayLike) -> Array:
        """ln(2 L/a(P))."""

    def log_area(self, load: ArrayLike, slipped: ArrayLike) -> Array:
        """Lam(P, P_c) = int_{P_c}^P ln(a(eta)/a(P_c)) d eta from P and P - P_c."""


def corner_loads(contact: Contact) -> Array:
    """Loads at which an edge is at a corner of the profile, (n,) ascending: there P(a) is smooth only in parts."""
    return np.asarray(contact.load(np.array(getattr(contact, "breaks", ()), dtype=float)))


def bends_anywhere(contact: Contact) -> bool:
    """Whether P(a) may bend sharply between its corners, where it hardly grows; closed forms never do, see `Pile`."""
    return bool(getattr(contact, "bends_anywhere", False))


def contact_of(profile: Profile, materials: Materials) -> Contact:
    """The mechanics of a scene's profile.

    Raises
    ------
    InputError
        For a kind of profile that this engine does not know.
    """
    modulus, datum = composite_modulus(materials), getattr(profile, "datum_length", 0.0)
    match profile:
        case Hertz():
            return HertzContact(modulus, profile.radius, datum)
        case FlatRounded():
            return FlatRoundedContact(modulus, profile.radius, profile.flat_half_length, datum)
        case PowerLaw():
            return PowerLawContact(modulus, profile.exponent, profile.length, profile.rise, datum)
        case Compound():
            return CompoundContact(modulus, datum, profile.inner_radius, profile.outer_radius, profile.inner_half_length)
        case Wedge():
            return wedge_contact(modulus, profile.tip_radius, profile.tip_half_length, datum)
        case EvenPolynomial():
            return PolynomialContact(modulus, datum, profile.length, profile.rises)
        case Tabulated():
            return tabulated_contact(modulus, profile)
        case CallableProfile():
            return callable_contact(modulus, profile)
    raise InputError(f"profile.kind = {profile.kind!r}: the half-plane engine does not know this profile")
