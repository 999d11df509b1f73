"""What quadratures and series may have cost an answer: estimates from above, where a profile has no closed forms.

# notation: M' slope of the memory curve, |M'| <= f; W dissipation, Lam slip area of the normal problem

A field is a sum of M' times differences of a kernel at the knots of the memory: its error is that of the kernel, f times, twice a
knot. Integrals over arcs come with their error. The dissipation of a steady cycle is found as f int Lam dw and as closed-int Q dU:
what the two differ by counts as error. Long series are integrated once, their sample of slip areas counts.

The kernels of Hertz are closed forms and have no entry: they keep 1e-13 of their own value against forty digits. Of them only what
arcs may have lost beyond 1e-12 is stated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import NotFoundError
from semi_analytic.history import Span
from semi_analytic.memory import PROMISED, Snapshot, level, pieces
from semi_analytic.profiles import Contact, SymmetricContact
from semi_analytic.request import Request
from semi_analytic.tilted_profile import TiltedProfile

Array = NDArray[np.float64]

_INSTANTS = 7
_POINTS = 25
# Of closed forms: a twentieth of what a solution costs.
_FEW_INSTANTS = 5
_FEW_POINTS = 9
_NEAR = 0.01
_TINY = float(np.finfo(float).tiny)
_EPS = float(np.finfo(float).eps)


def field_errors(
    asked: Request,
    snapshot: Snapshot,
    lines: dict[str, Array],
    grids: dict[str, NDArray[np.float64]],
    arc_errors: Mapping[str, float],
) -> dict[str, float]:
    """Largest errors of pressure, shear and slip over the largest value of p, f p and s, from a sample of instants and points.

    Tractions start like roots at the edges of contact and stick, so that a last digit of an edge counts for much more next to it:
    "... at the edge" is for the points that are asked for, however near; without these words for points 1 % of a away.
    `arc_errors` are those of the integrals over arcs. Profiles in closed form state what their arcs lose beyond 1e-12.

    Raises
    ------
    NotFoundError
        For an error that is not a number.
    """
    contact, friction, arcs = asked.contact, snapshot.friction, {"shear": 0.0, "slip": 0.0}
    if asked.fields.isdisjoint(("pressure", *arcs)):
        return {}
    instants, points = (_INSTANTS, _POINTS) if not contact.closed_form else (_FEW_INSTANTS, _FEW_POINTS)
    chosen = np.unique(np.linspace(0, len(snapshot.load) - 1, instants).astype(int))
    loads = np.unique(np.append(snapshot.load[chosen], np.max(snapshot.load)))[:, None]
    x = asked.distance[np.unique(np.linspace(0, len(asked.distance) - 1, points).astype(int))]
    p = contact.pressure(x, loads)
    # It is infinite at the tip of a sharp wedge.
    top = max(float(np.max(p, where=np.isfinite(p), initial=0.0)), _TINY)
    if "shear" in asked.fields and friction > 0:
        arcs["shear"] = _largest(arc_errors["shear"]) / (friction * top)
    if "slip" in asked.fields:
        size = max(float(np.max(np.abs(grids["slip"]))) * math.pi * asked.modulus / 2, _TINY)
        arcs["slip"] = _largest(arc_errors["slip"]) / size
    if contact.closed_form or isinstance(contact, TiltedProfile):
        return {name: value for name, value in arcs.items() if value > PROMISED}
    knots = 2 * max((sum(1 for _ in pieces(snapshot.actives[k])) for k in snapshot.which[chosen]), default=0) + 2
    found: dict[str, float] = {}
    if not asked.fields.isdisjoint(("pressure", "shear")) and top > _TINY:
        found |= _of_tractions(contact, asked.distance, x, loads, top, lines, knots, arcs["shear"])
    if "slip" in asked.fields:
        found["slip"] = arcs["slip"] + knots * friction * _largest(contact.quadrature_error("slip_integral", x, loads)) / size
    return {name: value for name, value in found.items() if name.removesuffix(" at the edge") in asked.fields}


def _of_tractions(
    contact: SymmetricContact, points: Array, x: Array, loads: Array, top: float, lines: dict[str, Array], knots: int, arcs: float
) -> dict[str, float]:
    """Errors of pressure and shear over `top` and f times it, away from the edges and at those next to `points`."""
    away = np.abs(x - contact.half_width(loads)) > _NEAR * contact.half_width(loads)
    kernel = _largest(np.where(away, contact.quadrature_error("pressure", x, loads), 0.0)) / top
    found: dict[str, float] = {}
    for words, near in (("", _NEAR), (" at the edge", 0.0)):
        halves = (lines["contact_half_width"], lines["stick_half_width"])
        edges, fronts = (_at_edges(contact, points, half, near) / top for half in halves)
        found[f"pressure{words}"] = kernel + edges
        found[f"shear{words}"] = arcs + knots * kernel + edges + 2 * fronts
    return found


def _largest(values: ArrayLike) -> float:
    largest = float(np.max(np.asarray(values, dtype=float), initial=0.0))
    if not math.isfinite(largest):
        raise NotFoundError("an error that is to be estimated is not a number: what it is of cannot be trusted")
    return largest


def _at_edges(contact: SymmetricContact, x: Array, half: Array, least: float) -> float:
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


def dissipation_error(contact: Contact, spans: Sequence[Span], modulus: float, first: float, second: float) -> float:
    """Error of the dissipation `first` over itself, `second` being that of the closed integral; NaN where it has none."""
    if contact.closed_form or not first > 0:
        return 0.0
    left = 0.0
    for span in spans:
        if span.direction and span.active is not None:
            times = np.linspace(span.begin.time, span.end.time, 9)[1:-1]
            load, slipped = span.leg.loads(times)[0], span.slipped(times)
            growth = np.maximum(span.leg.rate_of(level(span.direction, span.friction), times), 0.0)
            error = contact.quadrature_error("dissipation_kernel", load, slipped)
            left += span.friction * _largest(growth * error) * (span.end.time - span.begin.time)
    apart = abs(second - first) / first if math.isfinite(second) else 0.0
    return apart + 2 / (math.pi * modulus) * left / first
