"""How far values along one memory curve may be from exact ones, as theory states it: one relative
estimate for each kernel, and what each quantity makes of it.

Every value is a sum over the pieces of the memory curve, or an integral over its spans, of kernels
of the normal contact P(a). A kernel's estimate (`quadrature_error` of the contact) is what its
quadrature and its last digits may be off; 0 of closed forms.

| kernel | quantity: what it makes of the estimate |
|---|---|
| p(x, P) | p: once; q: once for each kernel of the sum |
| slip integral | s: once for each kernel of the sum |
| Lam = int ln(a/c) d eta | W: once, since all terms are positive |
| d = P - P_c, which slips | s: eight times; W and W(x): three times |
| int ln(2 L/a) d eta | U: once |

Of grids and of steps of a rig each value has the change from coarser ones, in `grid` and
`answer_of_rig`.

Tractions begin like roots at the edges of contact and stick. A last digit of an edge counts for
much more next to it, so that p and q have a second estimate, "at the edge".

# notation: P_c load at the stick edge, c its half-width; W ~ d^3 and s ~ d^(3/2) where d is small
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from scenes.array_types import Array, Indices
from semi_analytic.answer import largest_error
from semi_analytic.history import Span, slipped_share
from semi_analytic.memory import LAST_DIGITS, PROMISED, level
from semi_analytic.profiles import Contact, SymmetricContact
from semi_analytic.tilted_profile import TiltedProfile

_EPS = float(np.finfo(float).eps)
_TINY = float(np.finfo(float).tiny)
# Share of a half-width within which a point is at an edge.
_NEAR = 0.01
# Last digits of a half-width by which it may be wrong.
_DIGITS_OF_EDGE = 40
# Relative error of each quantity over that of d: one and a half for slip and three for work by
# their power of d, the rest by the digits of kernels that cancel. Measured: up to 4.5 times of
# slip, on a short flat face.
_BY_SLIPPED_LOAD = {"slip": 8, "dissipation": 3, "dissipation_density": 3}
# Places, and times within a span, at which kernels are looked at.
_PLACES = 25
_TIMES = 7
# So many times that round-off may be in the loop of Q over U where U is no closed form: fifty last
# digits of each primitive in a difference of two.
_OF_LOOP = 100.0
# Below this share of P in P - P_c the integral of Q dU has been 1e-3 to 0.1 of W off where P nearly
# vanishes, more than its rounding: there Lam is an integral of positive terms over a range on which
# P(a) is a line, and needs no second route.
_SLIPS_ENOUGH = 1e-6


def error_by_slipped_load(quantity: str, share: float) -> float:
    """Relative error of "slip", "dissipation" or "dissipation_density" by the last digits of the
    load at the stick edge, where d = `share` P slips; 0 where that is below what closed forms
    promise, or nothing slips.
    """
    error = LAST_DIGITS / share if share > 0 else 0.0
    if max(_BY_SLIPPED_LOAD.values()) * error <= PROMISED:
        return 0.0
    return _BY_SLIPPED_LOAD[quantity] * error


def error_of_shift(friction: float, moments: Array, shifts: Array) -> float:
    """Relative error of the tangential displacement by round-off of its logarithmic integrals, sums
    that cancel; 0 where it is below what closed forms promise, or nothing moves.

    Parameters
    ----------
    friction
        f
    moments
        (n,) int ln(2 L/a) d eta up to the load of each instant
    shifts
        (n,) int M' ln(2 L/a) d eta along the memory curve, the displacement in the unit of
        `moments`. That curve is M(eta), the tangential force of the flat punches up to the load eta
    """
    largest_shift = float(np.max(np.abs(shifts)))
    if largest_shift <= 0:
        return 0.0
    largest_moment = float(np.max(np.abs(moments)))
    error = 2 * LAST_DIGITS * friction * largest_moment / largest_shift
    return error if error > PROMISED else 0.0


class Route(NamedTuple):
    """The closed integral of Q dU of a cycle, and its round-off, over A/pi [force^2 per
    thickness^2]; NaN where there is none.
    """

    work: float
    roundoff: float


def error_of_work(
    contact: Contact, spans: Sequence[Span], work: float, route: Route
) -> tuple[float, float]:
    """Relative errors of the friction work W of a cycle and of its other route, the closed integral
    of Q dU, by the kernel Lam and by what the two differ by.

    W keeps more digits where slip is tiny, so that the difference is the integral's own error. It
    counts for W too where neither round-off nor a tiny slip explains it.

    Parameters
    ----------
    spans
        of the cycle, times in full stick or with slip in one direction; none of a load series,
        whose records have the error of Lam in W already
    work
        W over A/pi [force^2 per thickness^2]
    route
        the closed integral
    """
    difference = abs(route.work / work - 1) if math.isfinite(route.work) and work > 0 else 0.0
    if contact.closed_form or not work > 0:
        return 0.0, difference
    error = math.fsum(_error_of_span(contact, span) for span in spans) / work
    # What the last digits of U leave in the loop says nothing of W.
    is_unexplained = difference > _OF_LOOP * route.roundoff / work
    if is_unexplained and slipped_share(spans) > _SLIPS_ENOUGH:
        error += difference
    return error, difference


def _error_of_span(contact: Contact, span: Span) -> float:
    """Error of the friction work f int Lam dw of a span by its kernel Lam, w = +-Q - f P; over
    A/pi [force^2 per thickness^2].
    """
    if not span.direction or span.sticking_piece is None:
        return 0.0
    times = np.linspace(span.begin.time, span.end.time, _TIMES + 2)[1:-1]
    load, _ = span.leg.loads(times)
    error = contact.quadrature_error("dissipation_kernel", load, span.slipped(times))
    growth = np.maximum(span.leg.rate_of(level(span.direction, span.friction), times), 0.0)
    return span.friction * largest_error(growth * error) * (span.end.time - span.begin.time)


@dataclass(frozen=True, eq=False)
class Sums:
    """Pressure, shear and slip as sums of kernels: where, and how large they are.

    Attributes
    ----------
    distance
        (k,) points |x|, ascending [length]
    load
        (n,) of a sample of instants [force per thickness]
    half_widths, stick_half_widths
        (m,) of contact and of stick, of all instants; NaN where there is none [length]
    friction
        f
    largest_slip
        over A/pi [force per thickness]
    n_kernels
        how many kernels the sums of shear and of slip have at most
    arc_errors
        errors of the integrals of shear [stress] and slip over A/pi along curved pieces, by name
    """

    distance: Array
    load: Array
    half_widths: Array
    stick_half_widths: Array
    friction: float
    largest_slip: float
    n_kernels: int
    arc_errors: Mapping[str, float]


def errors_of_sums(contact: Contact, sums: Sums) -> dict[str, float]:
    """Relative errors of pressure, shear and slip: 1 % of a half-width away from edges, and, with
    "at the edge" behind the name, at the points themselves, however near.

    Pressure is left out where there is none, slip where nothing slips.
    """
    places = sums.distance[_evenly_spread(len(sums.distance), _PLACES)]
    load = sums.load[:, None]
    largest_pressure = _largest_finite(contact.pressure(places, load))
    largest = {"shear": sums.friction * largest_pressure, "slip": sums.largest_slip}
    of_arcs = {
        name: largest_error(sums.arc_errors[name]) / size if size > _TINY else 0.0
        for name, size in largest.items()
    }
    if contact.closed_form or isinstance(contact, TiltedProfile):
        return {name: error for name, error in of_arcs.items() if error > PROMISED}
    errors: dict[str, float] = {}
    if largest_pressure <= _TINY:
        return errors
    half_width = contact.half_width(load)
    is_away = np.abs(places - half_width) > _NEAR * half_width
    kernel_errors = contact.quadrature_error("pressure", places, load)
    of_pressure = largest_error(np.where(is_away, kernel_errors, 0.0)) / largest_pressure
    for suffix, nearest in (("", _NEAR), (" at the edge", 0.0)):
        of_edge, of_stick_edge = (
            _error_beside_edges(contact, sums.distance, edges, nearest) / largest_pressure
            for edges in (sums.half_widths, sums.stick_half_widths)
        )
        errors[f"pressure{suffix}"] = of_pressure + of_edge
        of_sum = of_arcs["shear"] + sums.n_kernels * of_pressure
        errors[f"shear{suffix}"] = of_sum + of_edge + 2 * of_stick_edge
    if sums.largest_slip > _TINY:
        kernel_errors = contact.quadrature_error("slip_integral", places, load)
        of_slip = sums.friction * largest_error(kernel_errors) / sums.largest_slip
        errors["slip"] = of_arcs["slip"] + sums.n_kernels * of_slip
    return errors


def _evenly_spread(count: int, most: int) -> Indices:
    """Numbers of at most so many of `count` things, evenly spread, ascending."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def _largest_finite(values: Array) -> float:
    """The largest number; p is infinite at the tip of a sharp wedge."""
    return float(np.max(values, where=np.isfinite(values), initial=_TINY))


def _error_beside_edges(
    contact: SymmetricContact, x: Array, half_widths: Array, nearest: float
) -> float:
    """Largest error of the pressure next to an edge of contact or of stick [stress], by the error
    of its half-width a: (g/pi) sqrt(2 d/a) at the distance d, g = dP/da.

    d is that of the nearest of the points x (k,) ascending, and at least `nearest` times a. The
    half-widths (n,) may be NaN.
    """
    a = half_widths[np.isfinite(half_widths) & (half_widths > 0)]
    last_point = len(x) - 1
    point_after = np.clip(np.searchsorted(x, a), 1, max(last_point, 1))
    distance_before = np.abs(x[point_after - 1] - a)
    distance_after = np.abs(x[np.minimum(point_after, last_point)] - a)
    distance = np.maximum(np.minimum(distance_before, distance_after), nearest * a)
    stiffness = contact.stiffness(a)
    error_of_load = contact.noise * contact.load(a)
    positive_stiffness = np.where(stiffness > 0, stiffness, np.inf)
    error_of_edge = _DIGITS_OF_EDGE * _EPS * a + error_of_load / positive_stiffness
    change_of_root = np.sqrt(distance + error_of_edge) - np.sqrt(distance)
    return largest_error(stiffness / np.pi * np.sqrt(2 / a) * change_of_root)
