"""The third way to the friction work of a cycle: W(x) integrated over the contact.

# notation: P_c load at the front of slip, c = a(P_c)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from semi_analytic.contact import Contact
from semi_analytic.corners import smooth_spans
from semi_analytic.friction_work import pointwise_dissipation, uneven
from semi_analytic.history import Span
from semi_analytic.quadrature import graded
from semi_analytic.settling import SETTLED, Settled, settled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Share of the contact within which two kinks are one.
_SHORTEST = 1e-12


def work_over_points(contact: Contact, modulus: float, spans: Sequence[Span], work: float) -> Settled:
    """Integral of W(x) over the whole contact [energy per unit thickness], and its error; `work` is about what it will be.

    Cut at every kink of W(x); where fronts run by no formula W(x) may be steep anywhere, and is settled by halving in between.
    """

    def rule(_: Indices, low: Array, high: Array) -> Array:
        x, weight = graded(low, high)
        density = pointwise_dissipation(contact, modulus, spans, x.ravel()).total
        return 2 * np.sum(weight * density.reshape(x.shape), axis=-1)

    marks = kinks(contact, spans)
    if not any(uneven(contact, span) for span in spans):
        whole = float(np.sum(rule(np.arange(len(marks) - 1), marks[:-1], marks[1:])))
        return Settled(np.array(whole), np.array(0.0))
    found = settled(rule, marks[:-1], marks[1:], SETTLED * work)
    return Settled(np.asarray(np.sum(found.value)), np.asarray(np.sum(found.error)))


def kinks(contact: Contact, spans: Sequence[Span]) -> Array:
    """The x >= 0 between which W(x) is smooth, ascending: edges of contact and of stick where a span begins or ends.

    Spans that are cut at the corners of the profile count too: a front at a corner goes on with another speed, which the points
    feel that come into contact at that instant.
    """
    marks = [np.asarray(getattr(contact, "breaks", ()), dtype=float)]
    for span in smooth_spans(contact, spans):
        times = np.array([span.begin.time, span.end.time])
        load = span.leg.loads(times)[0]
        marks += [contact.half_width(load), contact.half_width(np.maximum(load - span.slipped(times), 0.0))]
    every = np.unique(np.concatenate(marks))
    every = every[every <= max(float(np.max(half)) for half in marks[1:])]
    return every[np.diff(every, prepend=-np.inf) > _SHORTEST * every[-1]]
