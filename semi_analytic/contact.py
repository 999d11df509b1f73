"""What the tangential problem asks of a profile: normal contact as a pile of flat punches."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import FlatRounded, Hertz, InputError, Materials, Profile
from semi_analytic.elasticity import composite_modulus
from semi_analytic.flat_rounded import FlatRoundedContact
from semi_analytic.hertz import HertzContact

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


def contact_of(profile: Profile, materials: Materials) -> Contact:
    """The mechanics of a scene's profile.

    Raises
    ------
    InputError
        For a kind of profile that this engine does not know.
    """
    modulus = composite_modulus(materials)
    if isinstance(profile, Hertz):
        return HertzContact(modulus, profile.radius, profile.datum_length)
    if isinstance(profile, FlatRounded):
        return FlatRoundedContact(modulus, profile.radius, profile.flat_half_length, profile.datum_length)
    raise InputError(f"profile.kind = {profile.kind!r}: the half-plane engine does not know this profile")
