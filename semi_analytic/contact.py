"""What the tangential problem asks of a profile: normal contact as a superposition of flat punches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semi_analytic.profiles import Contact, contact_of

__all__ = ["Contact", "bends_anywhere", "contact_of", "corner_loads"]


def corner_loads(contact: Contact) -> NDArray[np.float64]:
    """Loads at which an edge is at a corner of the profile, (n,) ascending: there P(a) is smooth only in parts."""
    return contact.break_loads


def bends_anywhere(contact: Contact) -> bool:
    """Whether P(a) may bend sharply between its corners, where it hardly grows."""
    return contact.bends_anywhere
