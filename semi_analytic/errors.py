"""What quadratures and series may have cost an answer: estimates from above, where a profile has no closed forms.

# notation: M' slope of the memory curve, |M'| <= f; W dissipation, Lam slip area of the normal problem

A field is a sum of M' times differences of a kernel at the knots of the memory: its error is that of the kernel, f times, twice a
knot. Arcs are integrated by two rules that share nothing but the kernel; so is the dissipation of a steady cycle, as f int Lam dw
and as closed-int Q dU. What two ways differ by counts as error. Long series are integrated once, their sample of slip areas counts.

Profiles in closed form have no entry: Hertz, flat and rounded, and power laws, whose special functions and one quadrature keep
1e-13 of their own value against forty digits (1.4e-13 for n = 20).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import EllipseLeg
from semi_analytic.arcs import arc_shear, arc_slip
from semi_analytic.contact import Contact
from semi_analytic.curved import curved_shear, curved_slip
from semi_analytic.evaluation import Asked
from semi_analytic.history import Span
from semi_analytic.legs import level, rate
from semi_analytic.memory import front_time, pieces
from semi_analytic.pile import Pile
from semi_analytic.snapshot import Snapshot

Array = NDArray[np.float64]

_INSTANTS = 7
_POINTS = 25
_NEAR = 0.01
_TINY = float(np.finfo(float).tiny)
_EPS = float(np.finfo(float).eps)


def field_errors(
    asked: Asked, snapshot: Snapshot, lines: dict[str, Array], grids: dict[str, NDArray[np.float64]]
) -> dict[str, float]:
    """Largest errors of pressure, shear and slip over the largest value of p, f p and s, from a sample of instants and points.

    Tractions start like roots at the edges of contact and stick, so that a last digit of an edge counts for much more next to it:
    "... at the edge" is for the points that are asked for, however near; without these words for points 1 % of a away.
    """
    contact, friction = asked.contact, snapshot.friction
    if not isinstance(contact, Pile):
        return {}
    chosen = np.unique(np.linspace(0, len(snapshot.load) - 1, _INSTANTS).astype(int))
    loads = np.unique(np.append(snapshot.load[chosen], np.max(snapshot.load)))[:, None]
    x = asked.distance[np.unique(np.linspace(0, len(asked.distance) - 1, _POINTS).astype(int))]
    knots = 2 * max((sum(1 for _ in pieces(snapshot.actives[k])) for k in snapshot.which[chosen]), default=0) + 2
    found: dict[str, float] = {}
    top = float(np.max(contact.pressure(x, loads)))
    if not asked.fields.isdisjoint(("pressure", "shear")) and top > 0:
        away = np.abs(x - contact.half_width(loads)) > _NEAR * contact.half_width(loads)
        kernel = _largest(np.where(away, contact.quadrature_error("pressure", x, loads), 0.0)) / top
        half, stick = lines["contact_half_width"], lines["stick_half_width"]
        arcs = _arcs(contact, snapshot, chosen, x, "shear") / (friction * top) if "shear" in asked.fields and friction > 0 else 0.0
        for words, near in (("", _NEAR), (" at the edge", 0.0)):
            edges, fronts = (_at_edges(contact, asked.distance, at, near) / top for at in (half, stick))
            found[f"pressure{words}"] = kernel + edges
            found[f"shear{words}"] = arcs + knots * kernel + edges + 2 * fronts
    if "slip" in asked.fields:
        size = float(np.max(np.abs(grids["slip"]))) * math.pi * asked.modulus / 2
        left = knots * friction * _largest(contact.quadrature_error("spread", x, loads))
        found["slip"] = (left + _arcs(contact, snapshot, chosen, x, "slip")) / max(size, _TINY)
    return {name: value for name, value in found.items() if name.removesuffix(" at the edge") in asked.fields}


def _largest(values: ArrayLike) -> float:
    finite = np.asarray(values, dtype=float)
    return float(np.max(finite[np.isfinite(finite)], initial=0.0))


def _at_edges(contact: Pile, x: Array, half: Array, least: float) -> float:
    """What the error of a half-width does to a pressure (g/pi) sqrt(2 d/a) at the small distance d of the nearest point."""
    inside = half[np.isfinite(half) & (half > 0)]
    if not len(inside):
        return 0.0
    after = np.clip(np.searchsorted(x, inside), 1, max(len(x) - 1, 1))
    near = np.minimum(np.abs(x[after - 1] - inside), np.abs(x[np.minimum(after, len(x) - 1)] - inside))
    near = np.maximum(near, least * inside)
    rate = contact.stiffness(inside)
    doubt = 40 * _EPS * inside + contact.noise * contact.load(inside) / np.where(rate > 0, rate, np.inf)
    return _largest(rate / np.pi * np.sqrt(2 / inside) * (np.sqrt(near + doubt) - np.sqrt(near)))


def _arcs(contact: Contact, snapshot: Snapshot, chosen: NDArray[np.intp], x: Array, kernel: str) -> float:
    """Largest difference of the two rules over the arcs of ellipses on the memory curves of some instants."""
    worst = 0.0
    for k in chosen:
        for number, piece in enumerate(pieces(snapshot.actives[snapshot.which[k]])):
            leg = piece.anchor.leg
            if piece.arc is None or not isinstance(leg, EllipseLeg):
                continue
            upper = snapshot.load[k] - snapshot.slipped[k] if number == 0 else piece.top
            last, bottom = front_time(piece, np.array([upper])), np.array([piece.bottom])
            slope = leg.amplitude[1] * math.cos(leg.phase) / leg.amplitude[0]
            if kernel == "shear":
                straight = contact.pressure(x, np.array([upper])) - contact.pressure(x, bottom)
                one, two = arc_shear(contact, leg, piece.arc[0], last, x), curved_shear(contact, piece, last, x)
            else:
                straight = contact.spread(x, np.array([upper])) - contact.spread(x, bottom)
                one, two = arc_slip(contact, leg, piece.arc[0], last, x), curved_slip(contact, piece, last, x)
            worst = max(worst, _largest(np.abs(one[0] + slope * straight - two[0])))
    return worst


def dissipation_error(contact: Contact, spans: Sequence[Span], modulus: float, first: float, second: float) -> float:
    """Error of the dissipation `first` over itself, `second` being that of the closed integral; NaN where it has none."""
    if not isinstance(contact, Pile) or not first > 0:
        return 0.0
    left = 0.0
    for span in spans:
        if span.direction and span.active is not None:
            times = np.linspace(span.begin.time, span.end.time, 9)[1:-1]
            load, slipped = span.leg.loads(times)[0], span.slipped(times)
            growth = np.maximum(rate(span.leg, level(span.direction, span.friction), times), 0.0)
            error = contact.quadrature_error("log_area", load, slipped)
            left += span.friction * _largest(growth * error) * (span.end.time - span.begin.time)
    apart = abs(second - first) / first if math.isfinite(second) else 0.0
    return apart + 2 / (math.pi * modulus) * left / first
