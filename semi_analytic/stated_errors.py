"""Errors that half-plane theory states for its values along one memory curve.

A relative error is estimated for each kernel. The error of a quantity follows from those of its
kernels.

Every value is a sum over the pieces of the memory curve, or an integral over its spans, of kernels
of the normal contact P(a). A kernel's estimate (`quadrature_error` of the contact) is its error by
quadrature and round-off; 0 of closed forms.

| kernel | quantity: how often the estimate counts |
|---|---|
| p(x, P) | p: once; q: once for each kernel of the sum |
| slip integral | s: once for each kernel of the sum |
| Lam = int ln(a/c) d eta | W: once, since all terms are positive |
| d = P - P_c, which slips | s: eight times; W and W(x): three times |
| int ln(2 L/a) d eta | U: once |

On grids, and for the steps of a rig, the error is the change from a coarser solution: see `grid`
and `answer_of_rig`.

Tractions begin like square roots at the edges of contact and stick. A last digit of an edge counts
for much more next to it, so that p and q have a second estimate, "at the edge".

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
from semi_analytic.history import Span, slip_zone_share
from semi_analytic.memory import LAST_DIGITS, PROMISED_ERROR, slip_combination
from semi_analytic.profiles import Contact, SymmetricContact
from semi_analytic.tilted_profile import TiltedProfile

_EPS = float(np.finfo(float).eps)
_SMALLEST_FLOAT = float(np.finfo(float).tiny)
# Share of a half-width within which a point is at an edge.
_NEAR_EDGE = 0.01
# Last digits of a half-width by which it may be wrong.
_DIGITS_OF_EDGE = 40
# Relative error of each quantity over that of d: one and a half for slip and three for work by
# their power of d, the rest by the digits of kernels that cancel. Measured: up to 4.5 times of
# slip, on a short flat face.
_ERROR_OVER_THAT_OF_SLIP_LOAD = {"slip": 8, "dissipation": 3, "dissipation_density": 3}
# Places, and times within a span of slip, at which the errors of kernels are sampled.
_SAMPLED_PLACES = 25
_SAMPLED_TIMES = 7
# So many times that round-off may be in the loop of Q over U where U is no closed form: fifty last
# digits of each primitive in a difference of two.
_ROUNDOFF_OF_LOOP = 100.0
# Below this share of P in P - P_c the integral of Q dU has been 1e-3 to 0.1 of W off where P nearly
# vanishes, more than its rounding: there Lam is an integral of positive terms over a range on which
# P(a) is a line, and needs no second route.
_LEAST_SLIPPED_SHARE = 1e-6


def roundoff_error_of_little_slip(quantity: str, share: float) -> float:
    """Relative error of "slip", "dissipation" or "dissipation_density" by the last digits of P_c,
    the load at the stick edge.

    `share` is the load P - P_c of the slip zones over P. All three errors are 0 where nothing
    slips, or where the largest of them, that of slip, is within the accuracy of closed forms,
    1e-12. _ERROR_OVER_THAT_OF_SLIP_LOAD is 8 for slip, 3 for both others: the error over that of
    P - P_c.
    """
    # LAST_DIGITS: four round-offs
    error_of_slip_load = LAST_DIGITS / share if share > 0 else 0.0
    if max(_ERROR_OVER_THAT_OF_SLIP_LOAD.values()) * error_of_slip_load <= PROMISED_ERROR:
        return 0.0
    return _ERROR_OVER_THAT_OF_SLIP_LOAD[quantity] * error_of_slip_load


def error_of_displacement(friction: float, approaches: Array, displacements: Array) -> float:
    """Relative error of the tangential displacement over all instants, by round-off of its
    logarithmic integrals, sums that cancel.

    0 where it is below the accuracy of closed forms, 1e-12, or nothing moves. L is the length of
    the datum, a the contact half-width.

    Parameters
    ----------
    friction
        f
    approaches
        (n,) int_0^P ln(2 L/a) d eta at each instant: the normal approach over A/pi, A = 2/E* [force
        per thickness]
    displacements
        (n,) int_0^P M' ln(2 L/a) d eta: the tangential displacement over A/pi [force per
        thickness]. M(eta) is the tangential force of the flat punches up to the load eta
    """
    largest_displacement = float(np.max(np.abs(displacements)))
    if largest_displacement <= 0:
        return 0.0
    largest_approach = float(np.max(np.abs(approaches)))
    # LAST_DIGITS: four round-offs
    error = 2 * LAST_DIGITS * friction * largest_approach / largest_displacement
    return error if error > PROMISED_ERROR else 0.0


class LoopIntegral(NamedTuple):
    """The friction work of a cycle as the closed integral of Q dU, and its round-off error, over
    A/pi [force^2 per thickness^2], A = 2/E*; NaN where the loop is not known.
    """

    work: float
    roundoff: float


def error_of_work(
    contact: Contact, spans: Sequence[Span], work: float, loop_integral: LoopIntegral
) -> tuple[float, float]:
    """Relative error of the friction work W of a cycle, and relative difference of the closed
    integral of Q dU from W; U is the relative tangential displacement.

    The error of W is that of its kernel Lam = int ln(a/c) d eta; a and c are the half-widths of
    contact and of stick. Where slip is tiny W keeps more digits than the closed integral, whose
    error the difference then is. Elsewhere the difference counts for W too, unless round-off of the
    integral explains it. The error of closed forms (`has_closed_form`) is 0; so is the difference
    where W is 0 or the integral is not known.

    Parameters
    ----------
    spans
        of the cycle, times in full stick or with slip in one direction; none of a path of straight
        steps, whose work has the error of Lam already
    work
        W over A/pi, A = 2/E* [force^2 per thickness^2]
    loop_integral
        the closed integral of Q dU over A/pi, and its round-off
    """
    difference_of_loop = 0.0
    if math.isfinite(loop_integral.work) and work > 0:
        difference_of_loop = abs(loop_integral.work / work - 1)
    if contact.has_closed_form or not work > 0:
        return 0.0, difference_of_loop
    error = math.fsum(_error_of_span(contact, span) for span in spans) / work
    # Round-off of U in the loop is no error of W.
    # _ROUNDOFF_OF_LOOP: 100
    is_unexplained = difference_of_loop > _ROUNDOFF_OF_LOOP * loop_integral.roundoff / work
    # share: largest P - P_c over the largest P, P_c the load at the stick edge;
    # _LEAST_SLIPPED_SHARE: 1e-6
    if is_unexplained and slip_zone_share(spans) > _LEAST_SLIPPED_SHARE:
        error += difference_of_loop
    return error, difference_of_loop


def _error_of_span(contact: Contact, span: Span) -> float:
    """Error of the friction work f int Lam dw in one span of slip by the error of its kernel Lam,
    over A/pi [force^2 per thickness^2]; 0 in stick and gross sliding.

    w = +-Q - f P grows in slip. Lam is the integral of ln(a/c) over the loads from P_c, that at the
    edge of stick, to P. a and c are the half-widths of contact and of stick, A = 2/E*. The error is
    f times the duration of the span times the largest product of dw/dt and the error of Lam.

    Parameters
    ----------
    contact
        normal contact, which estimates the error of Lam
    span
        time with one direction of slip, 0 for none, on one load segment; `sticking_piece` is the
        piece of the memory curve that holds the stick edge, None if nothing sticks
    """
    if not span.direction or span.sticking_piece is None:
        return 0.0
    # seven times within the span
    times = np.linspace(span.begin.time, span.end.time, _SAMPLED_TIMES + 2)[1:-1]
    load, _ = span.segment.loads(times)
    slip_zone_load = span.slip_zone_load(times)  # P - P_c
    kernel_error = contact.quadrature_error("dissipation_kernel", load, slip_zone_load)
    growth_rate_of_w = np.maximum(
        span.segment.rate_of(slip_combination(span.direction, span.friction), times), 0.0
    )
    duration = span.end.time - span.begin.time
    return span.friction * largest_error(growth_rate_of_w * kernel_error) * duration


@dataclass(frozen=True, eq=False)
class SumsOfKernels:
    """Places, loads and sizes from which the errors of pressure, shear and slip follow. Each of
    these fields is a sum of kernels of the normal contact, one for each part of the memory curve:
    the tangential force of the flat punches up to each load.

    Attributes
    ----------
    distances
        (k,) points |x|, ascending [length]
    loads
        (n,) normal loads P at a sample of instants [force per thickness]
    half_widths, stick_half_widths
        (m,) of contact and of stick, of all instants; NaN where there is none [length]
    friction
        f
    largest_slip
        largest slip over A/pi [force per thickness]
    n_kernels
        how many kernels the sums of shear and of slip have at most
    arc_errors
        errors of the integrals of shear [stress] and slip over A/pi along curved pieces, by name
    """

    distances: Array
    loads: Array
    half_widths: Array
    stick_half_widths: Array
    friction: float
    largest_slip: float
    n_kernels: int
    arc_errors: Mapping[str, float]


def errors_of_sums(contact: Contact, sums: SumsOfKernels) -> dict[str, float]:
    """Relative errors of the sums of kernels that are pressure, shear and slip, by name.

    A kernel is a pressure or a slip integral of the `contact` under one load. A sum errs by the
    error of a kernel times the number of kernels. The errors hold farther than 1 % of a half-width
    from the edges of contact and of stick. With "at the edge" behind the name they hold at the
    points themselves, however near.

    Errors of pressure are over the largest p, of shear over the largest f p, of slip over the
    largest slip. Without pressure, or slip, its name is left out. Of closed forms and of tilted
    contacts the result has only the errors along arcs (curved pieces of the memory curve) that are
    above 1e-12.

    Parameters
    ----------
    contact
        normal contact of the profile
    sums
        points (`distances`), loads and half-widths at which kernels are sampled, the largest slip,
        and how many kernels a sum has at most (`n_kernels`)
    """
    # 25 points as columns, loads as rows
    sampled_places = sums.distances[_evenly_spread_numbers(len(sums.distances), _SAMPLED_PLACES)]
    load_column = sums.loads[:, None]
    largest_pressure = _largest_finite(contact.pressure(sampled_places, load_column))
    errors_of_arcs = _errors_along_arcs(sums, largest_pressure)
    if contact.has_closed_form or isinstance(contact, TiltedProfile):
        return {name: error for name, error in errors_of_arcs.items() if error > PROMISED_ERROR}
    if largest_pressure <= _SMALLEST_FLOAT:
        return {}
    half_width = contact.half_width(load_column)
    # farther than 1 % of a half-width
    is_off_edge = np.abs(sampled_places - half_width) > _NEAR_EDGE * half_width
    pressure_kernel_errors = contact.quadrature_error("pressure", sampled_places, load_column)
    pressure_kernel_error = (
        largest_error(np.where(is_off_edge, pressure_kernel_errors, 0.0)) / largest_pressure
    )
    errors = _errors_of_tractions(
        contact, sums, largest_pressure, pressure_kernel_error, errors_of_arcs["shear"]
    )
    if sums.largest_slip > _SMALLEST_FLOAT:
        slip_kernel_errors = contact.quadrature_error("slip_integral", sampled_places, load_column)
        slip_kernel_error = sums.friction * largest_error(slip_kernel_errors) / sums.largest_slip
        errors["slip"] = errors_of_arcs["slip"] + sums.n_kernels * slip_kernel_error
    return errors


def _errors_of_tractions(
    contact: SymmetricContact,
    sums: SumsOfKernels,
    largest_pressure: float,
    kernel_error: float,
    error_along_arcs: float,
) -> dict[str, float]:
    """Relative errors of pressure and shear off the edges, "pressure" and "shear", and at all
    points, with "at the edge" behind the name.

    Off the edges means farther than 1 % of a half-width from those of contact and of stick.
    The pressure is one kernel, the shear a sum of `n_kernels` at most. To their errors come those
    by the half-width of contact and, for the shear, of stick.

    Parameters
    ----------
    contact
        normal contact of the profile
    sums
        points (`distances`), half-widths of contact and stick, and `n_kernels`
    largest_pressure
        largest p [stress]
    kernel_error
        error of a pressure kernel, over the largest p
    error_along_arcs
        error of the shear along curved pieces of the memory curve, over the largest f p
    """
    errors: dict[str, float] = {}
    # at least 1 % of a half-width from an edge, or none
    for suffix, nearest_share in (("", _NEAR_EDGE), (" at the edge", 0.0)):
        error_by_contact_edge, error_by_stick_edge = (
            _error_beside_edges(contact, sums.distances, half_widths, nearest_share)
            / largest_pressure
            for half_widths in (sums.half_widths, sums.stick_half_widths)
        )
        errors[f"pressure{suffix}"] = kernel_error + error_by_contact_edge
        error_of_shear_sum = error_along_arcs + sums.n_kernels * kernel_error
        errors[f"shear{suffix}"] = (
            error_of_shear_sum + error_by_contact_edge + 2 * error_by_stick_edge
        )
    return errors


def _errors_along_arcs(sums: SumsOfKernels, largest_pressure: float) -> dict[str, float]:
    """Relative errors of the integrals of shear and of slip along arcs of the memory curve, by the
    names "shear" and "slip".

    An arc is a curved piece of the curve, the tangential force of the flat punches up to each load.
    They are the `arc_errors` of `sums` over the largest f p and the largest slip; 0 where these are
    0. `largest_pressure` is the largest p [stress].
    """
    largest_values = {"shear": sums.friction * largest_pressure, "slip": sums.largest_slip}
    return {
        name: largest_error(sums.arc_errors[name]) / largest_value
        if largest_value > _SMALLEST_FLOAT
        else 0.0
        for name, largest_value in largest_values.items()
    }


def _evenly_spread_numbers(n_values: int, most_numbers: int) -> Indices:
    """Indices of at most `most_numbers` of `n_values` values, evenly spread, ascending."""
    return np.unique(np.linspace(0, n_values - 1, most_numbers).astype(int))


def _largest_finite(values: Array) -> float:
    """The largest finite value, 2e-308 at least; the tip of a sharp wedge has infinite pressure."""
    return float(np.max(values, where=np.isfinite(values), initial=_SMALLEST_FLOAT))


def _error_beside_edges(
    contact: SymmetricContact, x: Array, half_widths: Array, nearest_share: float
) -> float:
    """Largest error of the pressure next to an edge of contact or of stick [stress], by the error
    of the half-width a of that edge.

    At the distance d from the edge p = (g/pi) sqrt(2 d/a), g = dP/da. P(a) is the load under which
    the contact has the half-width a. The result is the change of p where d grows by the error of a.

    Parameters
    ----------
    contact
        normal contact: P(a), its relative error (`relative_roundoff`), and g (`stiffness`)
    x
        (k,) ascending points; d is the distance of the nearest one from an edge [length]
    half_widths
        (n,) values of a, NaN where there is no edge [length]
    nearest_share
        d is at least this share of a
    """
    edge_half_width = half_widths[np.isfinite(half_widths) & (half_widths > 0)]
    last_point = len(x) - 1
    point_after_edge = np.clip(np.searchsorted(x, edge_half_width), 1, max(last_point, 1))
    distance_to_point_before = np.abs(x[point_after_edge - 1] - edge_half_width)
    distance_to_point_after = np.abs(x[np.minimum(point_after_edge, last_point)] - edge_half_width)
    distance = np.maximum(
        np.minimum(distance_to_point_before, distance_to_point_after),
        nearest_share * edge_half_width,
    )
    stiffness = contact.stiffness(edge_half_width)
    # error of a: 40 last digits, plus the error of P(a) over dP/da
    load_error = contact.relative_roundoff * contact.load(edge_half_width)
    positive_stiffness = np.where(stiffness > 0, stiffness, np.inf)
    half_width_error = _DIGITS_OF_EDGE * _EPS * edge_half_width + load_error / positive_stiffness
    change_of_square_root = np.sqrt(distance + half_width_error) - np.sqrt(distance)
    return largest_error(stiffness / np.pi * np.sqrt(2 / edge_half_width) * change_of_square_root)
