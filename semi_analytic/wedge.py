"""Normal contact of a wedge with a rounded tip: h' = x/R up to x = b, then b/R."""

from __future__ import annotations

import math

from semi_analytic.compound import CompoundContact


def wedge_contact(modulus: float, tip_radius: float, tip_half_length: float, datum_length: float) -> CompoundContact:
    """The compound curvature whose outer radius is infinite: P = (E*/R) [b tau + a^2 arcsin(b/a)]/2.

    >>> contact = wedge_contact(modulus=2.0, tip_radius=1.0, tip_half_length=1.0, datum_length=1.0)
    >>> round(float(contact.load(1e6)) / 1e6, 12)  # far beyond the tip P tends to that of a sharp wedge, E* (b/R) a
    2.0
    """
    return CompoundContact(modulus, datum_length, tip_radius, math.inf, tip_half_length)
