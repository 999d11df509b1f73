"""Spans cut where an edge of contact or of stick passes a corner of the profile: quadrature over time sees smooth functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from semi_analytic.contact import Contact, corner_loads
from semi_analytic.history import Span
from semi_analytic.legs import NORMAL_LOAD, change_from, instant, level, time_of
from semi_analytic.memory import level_on


def has_corners(contact: Contact) -> bool:
    """Whether P(a) of the profile is smooth only in parts."""
    return bool(getattr(contact, "breaks", ()))


def smooth_spans(contact: Contact, spans: Sequence[Span]) -> Sequence[Span]:
    """The spans, each cut at the times at which P or P_c is the load of a corner."""
    loads = corner_loads(contact)
    if not len(loads):
        return spans
    return [part for span in spans for part in _parts(span, loads)]


def _parts(span: Span, loads: NDArray[np.float64]) -> list[Span]:
    leg, first, last = span.leg, span.begin, span.end
    inside = loads[(loads > min(first.normal, last.normal)) & (loads < max(first.normal, last.normal))]
    times = time_of(leg, NORMAL_LOAD, inside - first.normal, first.time, last.time).tolist() if len(inside) else []
    if span.direction and span.active is not None:
        here = loads[(loads > span.active.bottom) & (loads < span.active.top)]
        if len(here):
            what = level(span.direction, span.friction)
            amount = level_on(span.active, span.direction, span.friction, here)
            amount = amount - float(change_from(span.active.anchor, leg, what, first.time))
            times += time_of(leg, what, amount, first.time, last.time).tolist()
    shortest = 1e-12 * max(abs(first.time), abs(last.time), last.time - first.time)
    marks = [first.time]
    for time in sorted(times):
        if time - marks[-1] > shortest and last.time - time > shortest:
            marks.append(time)
    if len(marks) == 1:
        return [span]
    stations = [first, *(instant(leg, time) for time in marks[1:]), last]
    return [replace(span, begin=begin, end=end) for begin, end in pairwise(stations)]
