"""Stress inside both half-planes, for every profile and every memory curve: Muskhelishvili's
potential of the flat punches.

A flat punch of half-width a under unit load has the potential i/(2 pi sqrt(z^2 - a^2)), z = x + i y
(Muskhelishvili 1953). The contact is a superposition of such punches, each with its share M' d eta
of the tangential load, so

    N(z) = int_0^P d eta / sqrt(z^2 - a^2),   T(z) = int_0^P M'(eta) d eta / sqrt(z^2 - a^2)

    pi s_xx = -Im N - 2 Re T - y (Re N' - Im T')
    pi s_yy = -Im N          + y (Re N' - Im T')          y <= 0, in the lower body
    pi s_xy =  Im T          + y (Im N' + Re T')

On the face s_yy = -p, s_xy = q, s_xx = -p - (2/pi) Re T: only punches narrower than |x| stretch the
face at x, and the tension at the trailing edge is (2/pi) int M' d eta / sqrt(a(P)^2 - a(eta)^2).
For the parabola under P alone this is McEwen (1949).

With bulk stress, tilt or unequal sides there is no one curve of punches of one middle. N and T then
come from the tractions of the answer: with x = m + h cos(phi), p = sum A_k sin(k phi) and zeta = (z
- m)/h, N = pi sum A_k (zeta - sqrt(zeta^2 - 1))^k. The bulk stress of the body is added.

# notation: eta normal load, a(eta) half-width, M(eta) tangential load of the punches up to eta, f
#           friction, delta = a - |x|; m, h middle and half-width of the contact
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from scenes import ContactSolution, InputError, Scene, scene_of
from scenes.array_types import Array, Indices
from semi_analytic.answer import vector
from semi_analytic.answer_by_memory import memory_at
from semi_analytic.bulk_and_tilt import leaning_profile
from semi_analytic.memory import CurvePart, Snapshot, pieces
from semi_analytic.profiles import SymmetricContact
from semi_analytic.quadrature import INVERSE_ROOTS
from semi_analytic.solution import solve
from semi_analytic.tilted_profile import TiltedProfile

Complex = NDArray[np.complex128]
Slope = Callable[[Array], Array]
Body = Literal["lower", "upper"]

# Kernels that are held at a time.
_AT_ONCE = 1_000_000
# Memory curves that are summed together, of some ten panels each.
_CURVES_AT_ONCE = 128
# Where there is no one memory curve: places across a contact at which q is asked for, and contacts
# of which; terms of the series.
_PLACES = 601
_CONTACTS = 4
_TERMS = 2048
# Instants that are solved together; places within a contact that are enough to take p and q from an
# answer that is there.
_TOGETHER = 20
_ENOUGH = 60
# Shares of a contact from its edges at which q is asked for too: slip has just begun there where a
# load has turned.
_RIM = 10.0 ** np.arange(-7, -1.5, 0.2)
# What straight lines of q/p between places leave of the tension, as share of f times the largest
# pressure: measured 5e-4.
_BETWEEN = 1e-3
# Powers of omega below it are left out.
_NEGLIGIBLE = 1e-17
# What quadrature leaves of a tension, as share of P/a.
_ROUNDING = 1e-11


def stress(
    source: ContactSolution | Scene | str | Path,
    x: ArrayLike,
    y: ArrayLike,
    instants: ArrayLike,
    *,
    body: Body = "lower",
) -> Array:
    """Stress inside one body, or on its face, at instants of the load path: s_xx, s_yy, s_xy, s_zz.

    Parameters
    ----------
    source
        the scene, its name or file, or a solution of it
    x, y
        (n_points,) places, or numbers that go with each other [length]; y points out of the lower
        body: y <= 0 in the lower one, y >= 0 in the upper one, 0 on its face
    instants
        (n_instants,) times of the load path
    body
        "lower" or "upper"

    Returns
    -------
    Array
        (n_instants, n_points, 4) s_xx, s_yy, s_xy and s_zz = nu (s_xx + s_yy), tension positive
        [stress]. To about 1e-11 of the largest pressure; infinite at the tip of a sharp wedge. With
        bulk stress, tilt or unequal sides the bulk stress is in it, and it is as exact as the shear
        of `solve`, at most to about 1e-3 of f times the largest pressure. The coupling of unlike
        materials is neglected.

    Raises
    ------
    InputError
        For a place outside the body, a time outside the path, or numbers that are not finite.
    InadmissibleLoadError
        For gross sliding or separation anywhere in the path.

    Examples
    --------
    >>> import numpy as np
    >>> a, p0 = 1.0, 2 * 90.62286500739786 / np.pi
    >>> on_axis = (
    ...     stress("hertz-normal", 0.0, -0.786, 1.0)[0, 0] / p0
    ... )  # largest shear of Hertz: 0.3003 p0 at 0.786 a
    >>> float(((on_axis[0] - on_axis[1]) / 2).round(4))
    0.3003
    """
    scene = source.scene if isinstance(source, ContactSolution) else scene_of(source)
    x_places, y_places, times = _places_and_times(x, y, instants)
    if body not in ("lower", "upper"):
        raise InputError(f"body: {body!r} is neither 'lower' nor 'upper'")
    side = 1.0 if body == "lower" else -1.0
    if np.any(side * y_places > 0):
        raise InputError(
            f"y: {side * float(np.max(side * y_places)):.6g} is outside the {body} body; y points"
            " out of the lower one"
        )
    depth = side * y_places
    poisson_ratio = getattr(scene.material, body).poisson_ratio
    stresses = np.zeros((len(times), len(x_places), 4))
    if scene.unsymmetric:
        answers = _with_tractions(source, times)
        _, profile = leaning_profile(scene)
        for k, (answer, row) in enumerate(answers):
            stresses[k, :, :3] = _from_sines(answer, row, profile, x_places, depth, side)
        stresses[..., 0] += _bulk(answers)[:, int(body == "upper"), None]
    else:
        contact, snapshot = memory_at(scene, times)
        for k in np.flatnonzero(snapshot.load > 0).tolist():
            normal_potential, tangential_potential, normal_slope, tangential_slope = _potentials(
                contact, _lines(snapshot, k), x_places, depth
            )
            stresses[k, :, :3] = _from_potentials(
                normal_potential,
                side * tangential_potential,
                depth * normal_slope,
                depth * side * tangential_slope,
            )
    stresses[..., 2] *= side
    stresses[..., 3] = poisson_ratio * (stresses[..., 0] + stresses[..., 1])
    return stresses


def _places_and_times(
    x: ArrayLike, y: ArrayLike, instants: ArrayLike
) -> tuple[Array, Array, Array]:
    """Places x and y as arrays of one length, (n,) each [length], and instants as an array (m,);
    InputError for what is missing or does not go together.
    """
    x_places = vector(x, "x")
    y_places = vector(y, "y")
    times = vector(instants, "instants")
    if x_places is None or y_places is None or times is None:
        raise InputError("stress: x, y and instants are needed")
    if len(x_places) != len(y_places) and min(len(x_places), len(y_places)) > 1:
        raise InputError(
            f"x and y: {len(x_places)} and {len(y_places)} places; give as many of both"
        )
    x_places, y_places = np.broadcast_arrays(x_places, y_places)
    return x_places, y_places, times


def edge_tension(
    source: ContactSolution | Scene | str | Path, instants: ArrayLike
) -> tuple[Array, Array]:
    """Stress s_xx along both faces at the edges of contact, where fretting cracks start, and its
    uncertainty [stress], tension positive.

    Without bulk stress, tilt and unequal sides it is +-(2/pi) int_0^P M'(eta) d eta / sqrt(a(P)^2 -
    a(eta)^2), M(eta) the tangential force carried up to the load eta. For Q > 0 at constant P that
    is tension at the left edge of the lower body and at the right one of the upper. Otherwise the
    bulk stress is in it.

    Parameters
    ----------
    source
        the scene, its name or file, or a solution of it; of a solution that holds an instant and
        has 60 points in the contact its own tractions are taken where the memory of friction is no
        single curve
    instants
        (n_instants,) times of the load path

    Returns
    -------
    values, uncertainties
        (n_instants, 2, 2) by body (lower, upper) and edge (left, right); out of contact the bulk
        stress alone

    Examples
    --------
    >>> from scenes import load_scene
    >>> scene = load_scene(
    ...     "cattaneo-mindlin"
    ... )  # Q = 0.6 f P at time 2: 2 f p0 sqrt(0.6), Cattaneo-Mindlin
    >>> f, p0 = scene.friction.coefficient, -stress(scene, 0.0, 0.0, 1.0)[0, 0, 1]
    >>> values, uncertainties = edge_tension(scene, 2.0)
    >>> (values[0] / (2 * f * p0 * 0.6**0.5)).round(9).tolist()
    [[1.0, -1.0], [-1.0, 1.0]]
    """
    scene = source.scene if isinstance(source, ContactSolution) else scene_of(source)
    times = vector(instants, "instants")
    if times is None:
        raise InputError("edge_tension: instants are needed")
    values = np.zeros((len(times), 2, 2))
    uncertainties = np.zeros((len(times), 2, 2))
    sign_of_body = np.array([[1.0], [-1.0]])
    if scene.unsymmetric:
        answers = _with_tractions(source, times)
        for k, (answer, row) in enumerate(answers):
            tension, uncertainties[k] = _tensions(answer, row)
            values[k] = sign_of_body * tension
        return values + _bulk(answers)[..., None], uncertainties
    contact, snapshot = memory_at(scene, times)
    in_contact = np.flatnonzero(snapshot.load > 0)
    signs = sign_of_body * [1.0, -1.0]
    for begin in range(0, len(in_contact), _CURVES_AT_ONCE):
        rows = in_contact[begin : begin + _CURVES_AT_ONCE]
        edges = np.atleast_1d(contact.half_width(snapshot.load[rows]))
        tensions = _tensions_of_curves(contact, snapshot, rows, edges)
        values[rows] = signs * tensions[:, None, None]
        uncertainties[rows] = (_ROUNDING * snapshot.load[rows] / edges)[:, None, None]
    return values, uncertainties


# ------------------------------------------------- from memory curves: all instants in one sum
class _Panel(NamedTuple):
    """The punches of half-widths `first` to `last` [length] of the memory curve of an instant, with
    M' of their loads.
    """

    instant: int
    first: float
    last: float
    slope: Slope


def _tensions_of_curves(
    contact: SymmetricContact, snapshot: Snapshot, in_contact: Indices, edges: Array
) -> Array:
    """Tension along the face at an edge of contact at instants in contact, (n,) [stress]: (2/pi)
    int_0^P M'(eta) d eta / sqrt(a(P)^2 - a(eta)^2).

    M(eta) is the tangential force carried up to the load eta, the friction memory at each instant.
    The integral is summed over panels of half-widths between kinks of M and corners of the profile.

    Parameters
    ----------
    in_contact
        (n,) numbers of the instants of the `snapshot`, which has M at several instants
    edges
        (n,) their half-widths a(P) [length]
    """
    panels = _panels_of_curves(contact, snapshot, in_contact, edges)
    instants = np.array([panel.instant for panel in panels])
    panel_begin = np.array([panel.first for panel in panels])[:, None]
    panel_end = np.array([panel.last for panel in panels])[:, None]
    edge = edges[instants, None]
    half_widths = _nodes_from(0.0, panel_begin, panel_end)
    distance_from_edge = _nodes_from(edge, panel_begin, panel_end)  # a(eta) - a(P)
    loads = contact.load(half_widths)
    slopes_at_nodes = np.empty_like(loads)  # M'
    for panel_number, panel in enumerate(panels):
        slopes_at_nodes[panel_number] = panel.slope(loads[panel_number])
    load_steps = (
        contact.stiffness(half_widths) * (panel_end - panel_begin) * INVERSE_ROOTS.weight
    )  # d eta
    panel_integrals = (
        load_steps
        * slopes_at_nodes
        / np.sqrt(-distance_from_edge * (2 * edge + distance_from_edge))
    ).sum(axis=1)
    sums = np.bincount(instants, weights=panel_integrals, minlength=len(in_contact))
    return np.asarray(2 / math.pi * sums)


def _panels_of_curves(
    contact: SymmetricContact, snapshot: Snapshot, in_contact: Indices, edges: Array
) -> list[_Panel]:
    """Ranges of half-widths over which the memory curves of the instants in contact are integrated:
    from kink to kink, cut at corners of the profile. A memory curve M(eta) is the tangential force
    of the flat punches up to the load eta.

    Parameters
    ----------
    in_contact
        (m,) numbers of the instants of the `snapshot`, which has the memory curves at several
        instants; a panel has the place of its instant among these
    edges
        (m,) half-width of contact at each [length]
    """
    instants: list[int] = []
    bottoms: list[float] = []
    tops: list[float] = []
    slopes: list[Slope] = []
    for instant_number, k in enumerate(in_contact.tolist()):
        for bottom, top, slope in _lines(snapshot, k):
            instants.append(instant_number)
            bottoms.append(bottom)
            tops.append(top)
            slopes.append(slope)
    begin_widths = np.atleast_1d(contact.half_width(np.array(bottoms)))
    # The half-width at P is the edge to the last digit: one digit more or less would move the
    # integral of the root by 1e-8.
    edge_of_line = edges[instants]
    reaches_edge = np.array(tops) == snapshot.load[in_contact][instants]
    half_width_at_top = np.minimum(contact.half_width(np.array(tops)), edge_of_line)
    end_widths = np.where(reaches_edge, edge_of_line, half_width_at_top)
    return [
        _Panel(instant, panel_begin, panel_end, slope)
        for instant, least_width, largest_width, slope in zip(
            instants, begin_widths.tolist(), end_widths.tolist(), slopes, strict=True
        )
        for panel_begin, panel_end in _cut(contact, least_width, largest_width)
    ]


# ----------------------------------------------- from tractions, where there is no one memory curve
def _with_tractions(
    source: ContactSolution | Scene | str | Path, times: Array
) -> list[tuple[ContactSolution, int]]:
    """For each of some instants a half-plane answer that has pressure and shear there, and the row
    of that instant: the source itself where it has points enough, or new answers.

    New ones have points at quadrature nodes of several of the contacts, and close to the edges of
    all.
    """
    answers: dict[float, tuple[ContactSolution, int]] = {}
    if isinstance(source, ContactSolution):
        scene = source.scene
        answers = _rows_with_tractions(source, times)
    else:
        scene = scene_of(source)
    missing_times = np.array(sorted(set(times.tolist()) - answers.keys()))
    if len(missing_times):
        for times_at_once in np.array_split(missing_times, -(-len(missing_times) // _TOGETHER)):
            edges = solve(scene, x=0.0, time=times_at_once, fields=()).contact_edges
            places = _places_in(edges[np.argsort(edges[:, 1] - edges[:, 0])])
            answer = solve(scene, x=places, time=times_at_once, fields=("pressure", "shear"))
            answers |= {time: (answer, row) for row, time in enumerate(times_at_once.tolist())}
    return [answers[time] for time in times.tolist()]


def _rows_with_tractions(
    answer: ContactSolution, times: Array
) -> dict[float, tuple[ContactSolution, int]]:
    """Rows of an answer for those of the instants `times` at which it holds pressure and shear at
    enough points of the contact, by instant.

    Empty where it has no tractions.
    """
    if not (np.isfinite(answer.pressure).all() and np.isfinite(answer.shear).all()):
        return {}
    rows = np.argmin(np.abs(answer.time[:, None] - times), axis=0)
    places_in_contact = np.sum(answer.pressure[rows] > 0, axis=1)
    is_enough = (places_in_contact >= _ENOUGH) | (answer.normal_load[rows] <= 0)
    is_held = np.abs(answer.time[rows] - times) <= 1e-9 * np.abs(times)
    time_numbers = np.flatnonzero(is_enough & is_held)
    return {float(times[k]): (answer, int(rows[k])) for k in time_numbers}


def _places_in(edges: Array) -> Array:
    """Places at the nodes of several contacts (n, 2), ascending in length, and close to the edges
    of all.
    """
    numbers = np.unique(np.linspace(0, len(edges) - 1, _CONTACTS).round().astype(int))
    chosen_edges = edges[numbers]
    cosines = np.cos(np.linspace(0, math.pi, _PLACES))
    nodes = chosen_edges.mean(axis=1)[:, None] - np.diff(chosen_edges) / 2 * cosines
    inwards = np.array([[1.0], [-1.0]])
    rims = edges[:, :, None] + np.diff(edges)[:, :, None] * inwards * _RIM
    return np.unique(np.concatenate([nodes.ravel(), rims.ravel()]))


def _bulk(answers: list[tuple[ContactSolution, int]]) -> Array:
    """Bulk stress of the lower and the upper body, (n, 2)."""
    stresses = np.zeros((len(answers), 2))
    for k, (answer, row) in enumerate(answers):
        if answer.bulk_stress_lower is not None:
            stresses[k, 0] = answer.bulk_stress_lower[row]
        if answer.bulk_stress_upper is not None:
            stresses[k, 1] = answer.bulk_stress_upper[row]
    return stresses


def _tensions(answer: ContactSolution, row: int) -> tuple[Array, float]:
    """Stress s_xx of the lower body at its left and right edge of contact at the instant number
    `row` of an answer, without the bulk stress, (2,), and its uncertainty [stress].

    It is +-(2/pi) int q/|x - edge| dx. With the distance to the edge = width sin^2(phi/2) the
    integral is int q cot(phi/2) d phi: straight between the points, and constant from the outermost
    one to the edge.

    The uncertainty is three times what half of the points changes, plus four times the stated error
    of the shear, plus what straight lines between points leave. The last two are shares of f times
    the largest pressure.
    """
    left_edge, right_edge = answer.contact_edges[row]
    points_in_contact = np.flatnonzero(
        (answer.pressure[row] > 0) & (answer.x > left_edge) & (answer.x < right_edge)
    )
    if not len(points_in_contact):
        return np.zeros(2), 0.0

    def integral_from_edge(distance_to_edge: Array, shear: Array) -> float:
        phi = 2 * np.arcsin(np.sqrt(distance_to_edge / (right_edge - left_edge)))
        weighted_shear = shear / np.tan(phi / 2)
        return float(
            np.trapezoid(np.append(weighted_shear[0], weighted_shear), np.append(0.0, phi))
        )

    def tensions_by(points: NDArray[np.intp]) -> Array:
        x = answer.x[points]
        shear = answer.shear[row, points]
        left_integral = integral_from_edge(x - left_edge, shear)
        right_integral = integral_from_edge((right_edge - x)[::-1], shear[::-1])
        return 2 / math.pi * np.array([left_integral, -right_integral])

    tension = tensions_by(points_in_contact)
    largest_change = 0.0
    for half_of_points in (points_in_contact[::2], points_in_contact[1::2]):
        if len(half_of_points):
            changes = np.abs(tensions_by(half_of_points) - tension)
            largest_change = max(largest_change, float(changes.max()))
    largest_friction = answer.scene.friction.coefficient * float(answer.pressure[row].max())
    share_of_error = 4 * answer.record.errors.get("shear", 0.0) + _BETWEEN
    return tension, 3 * largest_change + share_of_error * largest_friction


def _from_sines(
    answer: ContactSolution, row: int, profile: TiltedProfile, x: Array, y: Array, side: float
) -> Array:
    """Stress s_xx, s_yy, s_xy of a body below y = 0 at places (n,), (n, 3), from the tractions of
    an answer at the instant number `row`, without the bulk stress.

    # notation: zeta = (x + i y - middle)/half-width, omega = zeta - sqrt(zeta^2 - 1); N, T
    #           potentials of pressure and shear, N = pi sum A_k omega^k for p = sum A_k sin(k phi)

    p is exact, q/p straight between the points of the answer. Both are sine series across the
    contact, summed by Horner's rule. `side` is 1 for the lower body and -1 for the upper one, whose
    shear acts the other way.
    """
    is_in_contact = answer.pressure[row] > 0
    if not is_in_contact.any():
        return np.zeros((len(x), 3))
    left_edge, right_edge = answer.contact_edges[row]
    middle = (left_edge + right_edge) / 2
    half_width = (right_edge - left_edge) / 2
    places = middle + half_width * np.cos(math.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
    pressure = profile.pressure_over(places, np.atleast_1d(middle), np.atleast_1d(half_width))[0]
    ratio_at_points = answer.shear[row, is_in_contact] / answer.pressure[row, is_in_contact]
    shear_ratio = np.interp(places, answer.x[is_in_contact], ratio_at_points)
    sine_series = scipy.fft.dst(np.stack([pressure, side * shear_ratio * pressure]), 2) / _TERMS
    # In the mirror image, from above the cut of the root: the series have real coefficients.
    zeta = (x - middle + 0j) / half_width
    zeta.imag = np.abs(y) / half_width
    root_of_zeta = np.sqrt(zeta - 1) * np.sqrt(zeta + 1)
    omega = zeta - root_of_zeta
    sums = np.zeros((4, len(x)), dtype=complex)
    with np.errstate(divide="ignore"):
        log_of_omega = np.log(np.minimum(np.abs(omega), 1 - 1e-12))
        terms_needed = np.minimum(np.ceil(math.log(_NEGLIGIBLE) / log_of_omega), _TERMS)
    longest_first = np.argsort(-terms_needed, kind="stable")
    omega = omega[longest_first]
    points_with_term = np.searchsorted(
        -terms_needed[longest_first], -np.arange(1, _TERMS + 1), side="right"
    )
    for k in range(_TERMS, 0, -1):  # Horner's rule, from where omega^k counts
        n_points = points_with_term[k - 1]
        sums[:2, :n_points] = (sums[:2, :n_points] + sine_series[:, k - 1, None]) * omega[:n_points]
        sums[2:, :n_points] = (sums[2:, :n_points] + k * sine_series[:, k - 1, None]) * omega[
            :n_points
        ]
    sums[:, longest_first] = sums.copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        # y N', y T'; d omega/dz = -omega/(h root)
        slopes = np.where(y == 0, 0.0, -y * (sums[2:] / (half_width * root_of_zeta)).conj())
    return _from_potentials(*math.pi * sums[:2].conj(), *math.pi * slopes)


def _from_potentials(
    normal_potential: Complex,
    tangential_potential: Complex,
    y_normal_slope: Complex,
    y_tangential_slope: Complex,
) -> Array:
    """Stresses s_xx, s_yy, s_xy of a body below y = 0 at points (n,), (n, 3), by Muskhelishvili's
    potentials N of the pressure and T of the shear.

        pi s_xx = -Im N - 2 Re T - y (Re N' - Im T')
        pi s_yy = -Im N          + y (Re N' - Im T')
        pi s_xy =  Im T          + y (Im N' + Re T')

    `y_normal_slope` is y N', `y_tangential_slope` y T', (n,) complex each.
    """
    part_of_depth = y_normal_slope.real - y_tangential_slope.imag
    part_of_pressure = -normal_potential.imag
    components = (
        part_of_pressure - 2 * tangential_potential.real - part_of_depth,
        part_of_pressure + part_of_depth,
        tangential_potential.imag + y_normal_slope.imag + y_tangential_slope.real,
    )
    return np.stack(components, axis=-1) / math.pi


def _lines(snapshot: Snapshot, k: int) -> Iterator[tuple[float, float, Slope]]:
    """Lower load, upper load and slope M' of each part of the memory curve at instant number k,
    from the load P down to 0.

    The memory curve M(eta) is the tangential force carried up to the load eta. Its uppermost part,
    from the stick edge to P, is at the Coulomb limit.
    """
    load = float(snapshot.load[k])
    stick_edge_load = float(snapshot.load[k] - snapshot.slipped[k])
    if stick_edge_load < load:
        slope = float(snapshot.direction[k] * snapshot.friction)
        yield max(stick_edge_load, 0.0), load, lambda eta: np.full(eta.shape, slope)
    for piece in pieces(snapshot.uppermost_pieces[snapshot.piece_number[k]]):
        if piece.bottom < stick_edge_load:
            top = min(piece.top, stick_edge_load)
            yield piece.bottom, top, _slope_of(piece, snapshot.friction)


def _slope_of(piece: CurvePart, friction: float) -> Slope:
    """M'(eta) on a piece, |M'| <= f."""
    if piece.arc is None:
        return piece.slope_at
    return lambda eta: np.asarray(np.clip(piece.slope_at(eta), -friction, friction))


def _potentials(
    contact: SymmetricContact, lines: Iterator[tuple[float, float, Slope]], x: Array, y: Array
) -> Complex:
    """Muskhelishvili's potentials N of pressure and T of shear, and their derivatives, at x + i y,
    y <= 0: complex (4, n), summed over the flat punches of a contact.

    `lines` are the parts of the memory curve M(eta), the tangential force of the punches up to the
    load eta. Their slopes say what tangential load each punch has per normal load. The derivatives
    are left 0 on the face, where they only occur times y. Places with x < 0 follow by symmetry.
    """
    potentials = np.zeros((4, len(x)), dtype=complex)
    distance = np.abs(x)
    for bottom, top, slope in lines:
        begin_width, end_width = (float(contact.half_width(load)) for load in (bottom, top))
        for panel_ends in _cut(contact, begin_width, end_width):
            _add_panel(potentials, contact, slope, panel_ends, distance, y)
    potentials[:2, x < 0] = -potentials[:2, x < 0].conj()
    potentials[2:, x < 0] = potentials[2:, x < 0].conj()
    return potentials


def _cut(contact: SymmetricContact, low: float, high: float) -> Iterator[tuple[float, float]]:
    """Panels between two half-widths, cut where the profile has a break."""
    marks = [low, *(place for place in contact.breaks if low < place < high), high]
    for first, last in pairwise(marks):
        if last > first:
            yield first, last


def _nodes_from(place: ArrayLike, begin: ArrayLike, end: ArrayLike) -> Array:
    """Nodes of the rule for inverse roots between `begin` and `end`, minus `place`, without
    cancellation at either end; a new last axis is that of the nodes.
    """
    rule = INVERSE_ROOTS
    span_length = np.subtract(end, begin)
    distance_from_begin = np.subtract(begin, place) + span_length * rule.up
    distance_from_end = np.subtract(end, place) - span_length * rule.down
    return np.where(rule.up < 0.5, distance_from_begin, distance_from_end)


def _add_panel(
    potentials: Complex,
    contact: SymmetricContact,
    slope: Slope,
    ends: tuple[float, float],
    x: Array,
    y: Array,
) -> None:
    """Add to the potentials (4, n) at places x >= 0, y the flat punches with half-widths between
    the two `ends`, whose share of Q per load is `slope`.

    The potential of a punch has a root at |x| equal to its half-width: where that lies between the
    ends the range is cut there.
    """
    begin_width, end_width = ends
    panel_width = end_width - begin_width
    rule = INVERSE_ROOTS
    in_lower_half = rule.up < 0.5
    half_widths = _nodes_from(0.0, begin_width, end_width)
    panel_weights = _weights(contact, slope, half_widths, panel_width * rule.weight)
    is_cut = (x > begin_width) & (x < end_width)
    points_at_once = _AT_ONCE // len(rule.up)
    points_beside = np.flatnonzero(~is_cut)
    for point_numbers in np.array_split(points_beside, 1 + len(points_beside) // points_at_once):
        distance_to_punch = _nodes_from(x[point_numbers, None], begin_width, end_width)
        _add(potentials, point_numbers, panel_weights, distance_to_punch, x, y)
    points_in_panel = np.flatnonzero(is_cut)
    for point_numbers in np.array_split(
        points_in_panel, 1 + len(points_in_panel) // points_at_once
    ):
        x_of_points = x[point_numbers, None]
        for sign, part_end in ((-1.0, begin_width), (1.0, end_width)):
            part_width = sign * (part_end - x_of_points)
            distance_to_punch = sign * part_width * rule.up
            half_widths = np.where(
                in_lower_half,
                x_of_points + distance_to_punch,
                part_end - sign * part_width * rule.down,
            )
            weights_of_part = _weights(contact, slope, half_widths, part_width * rule.weight)
            _add(potentials, point_numbers, weights_of_part, distance_to_punch, x, y)


def _weights(
    contact: SymmetricContact, slope: Slope, half_widths: Array, node_weights: Array
) -> Array:
    """d eta and M' d eta of the nodes, (2, ...)."""
    rise = contact.stiffness(half_widths) * node_weights
    return np.stack([rise, rise * slope(contact.load(half_widths))])


def _add(
    potentials: Complex,
    point_numbers: NDArray[np.intp],
    weights: Array,
    distance_to_punch: Array,
    x: Array,
    y: Array,
) -> None:
    """Add the sums over flat punches, the last axis of `weights`, to the potentials (4, n) at some
    points: N of pressure, T of shear, and their derivatives.

    A punch of half-width a and unit load adds 1/sqrt(z^2 - a^2), z = x + i y.

    Parameters
    ----------
    point_numbers
        (m,) numbers of the points
    weights
        (2, nodes), or (2, m, nodes): load, and share of Q, of the punches at the nodes
    distance_to_punch
        (m, nodes) a - x, of which z^2 - a^2 is formed without cancellation
    x, y
        (n,) places of all points [length]
    """
    x_of_points = x[point_numbers, None]
    y_of_points = y[point_numbers, None]
    # The root is that of -0 i on the face: from inside the lower body.
    squared_root = np.empty(distance_to_punch.shape, dtype=complex)
    squared_root.real = (
        -distance_to_punch * (2 * x_of_points + distance_to_punch) - y_of_points * y_of_points
    )
    squared_root.imag = 2 * x_of_points * -np.abs(y_of_points)
    kernel = 1 / np.sqrt(squared_root)
    potentials[:2, point_numbers] += np.einsum(
        "...mn,mn->...m" if weights.ndim == 3 else "kn,mn->km", weights, kernel
    )
    in_body = np.flatnonzero(y_of_points[:, 0] != 0)
    if len(in_body):
        kernel = kernel[in_body] / squared_root[in_body]
        weights_in_body = weights[:, in_body] if weights.ndim == 3 else weights
        z = (x_of_points + 1j * y_of_points)[in_body, 0]
        potentials[2:, point_numbers[in_body]] -= z * np.einsum(
            "...mn,mn->...m" if weights.ndim == 3 else "kn,mn->km", weights_in_body, kernel
        )
