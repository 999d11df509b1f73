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
from weakref import WeakKeyDictionary

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from scenes import ContactSolution, InputError, Scene, scene_of
from scenes.array_types import Array, Complex, Indices
from semi_analytic.answer import checked_numbers
from semi_analytic.answer_by_memory import memory_at
from semi_analytic.bulk_and_tilt import PathLoads, path_loads_and_contact
from semi_analytic.grid import (
    CELLS_ACROSS_CONTACT,
    INCREMENTS_PER_CYCLE,
    GridRequest,
    RatioOnGrids,
    friction_ratio_on_grids,
)
from semi_analytic.memory import CurvePart, Snapshot, pieces
from semi_analytic.profiles import SymmetricContact
from semi_analytic.quadrature import RULE_FOR_INVERSE_ROOTS
from semi_analytic.solution import solve
from semi_analytic.tilted_profile import TiltedProfile

Slope = Callable[[Array], Array]
Body = Literal["lower", "upper"]

# Kernels 1/sqrt(z^2 - a^2) that are held at a time.
_KERNELS_AT_ONCE = 1_000_000
# Memory curves that are summed together, of some ten panels each.
_CURVES_AT_ONCE = 128
# Where there is no one memory curve: places across a contact at which q is asked for, contacts that
# are taken of those of all instants, and terms of the sine series.
_PLACE_COUNT_ACROSS_CONTACT = 601
_MOST_CONTACTS_WITH_PLACES = 4
_SERIES_TERMS = 2048
# Instants that are solved together; places within a contact that are enough to take p and q from a
# given answer.
_INSTANTS_AT_ONCE = 20
_FEWEST_PLACES_IN_CONTACT = 60
# Shares of a contact from its edges at which q is asked for too: slip has just begun there where a
# load has turned.
_WIDTH_SHARES_FROM_EDGE = 10.0 ** np.arange(-7, -1.5, 0.2)
# Places across a contact at which the pressure is taken for a tension.
_PLACES_OF_TENSION = 512
# Error of a tension on grids that its change by coarse grids does not show, over the error of the
# shear, each as share of its largest value: most below 0.005; 0.07 once, where a load has turned in
# between two increments.
_TENSION_ERROR_OVER_SHEAR_ERROR = 0.025
# What straight lines of q/p between places leave of the tension without grids, as share of f times
# the largest pressure: measured 5e-4.
_TENSION_ERROR_SHARE_BETWEEN_PLACES = 1e-3
# What is left of the change by half of the points, 1/(2^2 - 1): straight lines err by the square of
# the distance of points.
_ERROR_OVER_CHANGE_BY_POINTS = 1 / 3
# Tension that a slip zone adds which is narrower than a cell, over that of q = f p in the cell and
# the root of the difference of q/(f p) there: 2.7 if the cells had nothing of it. Measured 0.6 at
# most beside dense points, 1.4 where the nearest point is as far from the edge as a cell is wide.
_TENSION_OF_NARROW_SLIP_ZONE = 1.4
# Powers of omega below this are left out.
_NEGLIGIBLE_POWER = 1e-17
# Error of a tension by quadrature, as share of P/a.
_ROUNDOFF_OF_TENSION = 1e-11


def stress(
    source: ContactSolution | Scene | str | Path,
    x: ArrayLike,
    y: ArrayLike,
    instants: ArrayLike,
    *,
    body: Body = "lower",
) -> Array:
    """Stress s_xx, s_yy, s_xy, s_zz inside one half-plane, or on its face, at instants of the load
    path.

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
        of `solve`, at most to about 1e-3 of f times the largest pressure. Out of contact it is the
        bulk stress alone. The coupling of unlike materials is neglected.

    Raises
    ------
    InputError
        For a `body` of another name, a place outside it, a time outside the path, or numbers that
        are missing or not finite.
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
    sign_of_body = 1.0 if body == "lower" else -1.0
    if np.any(sign_of_body * y_places > 0):
        raise InputError(
            f"y: {sign_of_body * float(np.max(sign_of_body * y_places)):.6g} is outside the {body}"
            " body; y points out of the lower one"
        )
    depth = sign_of_body * y_places  # <= 0: the upper body as the mirror image of a lower one
    poisson_ratio = getattr(scene.material, body).poisson_ratio

    # In the upper body, mirrored to a lower one, shear and xy stress change their sign.
    stresses = np.zeros((len(times), len(x_places), 4))
    if scene.unsymmetric:  # bulk stress, tilt or unequal sides: from the tractions of solutions
        # For each instant a solution, and the number (row) of the instant in it.
        answers = _answers_with_tractions(source, times)
        _, profile = path_loads_and_contact(scene)
        for instant_number, (answer, row) in enumerate(answers):
            stresses[instant_number, :, :3] = _stress_by_sine_series(
                answer, row, profile, x_places, depth, sign_of_body
            )
        stresses[..., 0] += _bulk_stresses(answers)[:, int(body == "upper"), None]
    else:
        # From the memory curves of the instants, and Muskhelishvili's potentials N of pressure and
        # T of shear, with their derivatives.
        contact, snapshot = memory_at(scene, times)
        for instant_number in np.flatnonzero(snapshot.load > 0).tolist():
            normal_potential, tangential_potential, normal_derivative, tangential_derivative = (
                _potentials(contact, _curve_parts(snapshot, instant_number), x_places, depth)
            )
            stresses[instant_number, :, :3] = _stress_from_potentials(
                normal_potential,
                sign_of_body * tangential_potential,
                depth * normal_derivative,
                depth * sign_of_body * tangential_derivative,
            )
    stresses[..., 2] *= sign_of_body
    stresses[..., 3] = poisson_ratio * (stresses[..., 0] + stresses[..., 1])
    return stresses


def _places_and_times(
    x: ArrayLike, y: ArrayLike, instants: ArrayLike
) -> tuple[Array, Array, Array]:
    """Checked places x and y, broadcast to one length (n,) [length], and times (m,) of the
    instants; InputError where one is missing, or x and y differ in length and neither is single.

    `checked_numbers` returns a caller's finite numbers as an array, or None where none are given.
    """
    x_places = checked_numbers(x, "x")
    y_places = checked_numbers(y, "y")
    times = checked_numbers(instants, "instants")
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
    uncertainty [stress], at instants of the load path; tension is positive.

    Without bulk stress, tilt and unequal sides it is +-(2/pi) int_0^P M'(eta) d eta / sqrt(a(P)^2 -
    a(eta)^2). M(eta) is the tangential force carried by the flat punches up to the load eta. For Q
    > 0 at constant P that is tension at the left edge of the lower body and at the right one of the
    upper. With bulk stress, tilt or unequal sides the bulk stress is in it.

    Parameters
    ----------
    source
        the scene, its name or file, or a solution of it. With bulk stress, tilt or unequal sides
        the tractions of the solution itself are taken at instants that it holds, if it has 60
        points in the contact
    instants
        (n_instants,) times of the load path

    Returns
    -------
    values, uncertainties
        (n_instants, 2, 2) by body (lower, upper) and edge (left, right); out of contact the bulk
        stress alone; an uncertainty is NaN where coarse grids do not follow the path

    Raises
    ------
    InputError
        Without instants, or for a time outside the path.

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
    times = checked_numbers(instants, "instants")
    if times is None:
        raise InputError("edge_tension: instants are needed")
    values = np.zeros((len(times), 2, 2))
    uncertainties = np.zeros((len(times), 2, 2))
    sign_of_body = np.array([[1.0], [-1.0]])  # lower, upper
    if scene.unsymmetric:
        # For each instant a solution, and the number (row) of the instant in it.
        answers = _answers_with_tractions(source, times)
        path_loads, profile = path_loads_and_contact(scene)
        for instant_number, (answer, row) in enumerate(answers):
            coarse_grids = _ratio_on_coarse_grids(answer, path_loads, profile)
            tension, uncertainties[instant_number] = _edge_tensions_of_answer(
                answer, row, profile, coarse_grids
            )
            values[instant_number] = sign_of_body * tension
        return values + _bulk_stresses(answers)[..., None], uncertainties

    # Memory curves of all instants; P is `snapshot.load`. At most 128 curves are summed at once.
    contact, snapshot = memory_at(scene, times)
    instants_in_contact = np.flatnonzero(snapshot.load > 0)
    signs_of_tensions = sign_of_body * [1.0, -1.0]  # (bodies, edges)
    for first_index in range(0, len(instants_in_contact), _CURVES_AT_ONCE):
        instant_numbers = instants_in_contact[first_index : first_index + _CURVES_AT_ONCE]
        load = snapshot.load[instant_numbers]
        half_width = np.atleast_1d(contact.half_width(load))
        tensions = _edge_tensions_of_curves(contact, snapshot, instant_numbers, half_width)
        values[instant_numbers] = signs_of_tensions * tensions[:, None, None]
        # _ROUNDOFF_OF_TENSION: 1e-11 of P/a.
        uncertainties[instant_numbers] = (_ROUNDOFF_OF_TENSION * load / half_width)[:, None, None]
    return values, uncertainties


# ------------------------------------------------- from memory curves: all instants in one sum
class _Panel(NamedTuple):
    """Flat punches of half-widths from `first_half_width` to `last_half_width` [length] at one
    instant, with their tangential load per normal load, M' as a function of the load eta. `instant`
    is its number among those in contact.
    """

    instant: int
    first_half_width: float
    last_half_width: float
    slope: Slope


def _edge_tensions_of_curves(
    contact: SymmetricContact,
    snapshot: Snapshot,
    instants_in_contact: Indices,
    contact_half_widths: Array,
) -> Array:
    """Stress s_xx of the lower face at its left edge of contact at instants in contact, without the
    bulk stress, (n,) [stress]: (2/pi) int_0^P M'(eta) d eta / sqrt(a(P)^2 - a(eta)^2).

    M(eta) is the tangential force carried by the flat punches up to the load eta, the friction
    memory of each instant. The integral is summed over panels of half-widths between kinks of M and
    corners of the profile.

    Parameters
    ----------
    contact
        P(a) and dP/da (`stiffness`) of the profile on half-planes
    instants_in_contact
        (n,) numbers of the instants in the `snapshot`, which holds M of several instants
    contact_half_widths
        (n,) half-widths a(P) of the contact then [length]
    """
    # Each panel has its instant, first and last half-width, and M' as a function of the load.
    panels = _panels_of_curves(contact, snapshot, instants_in_contact, contact_half_widths)
    instant_numbers = np.array([panel.instant for panel in panels])
    panel_begin = np.array([panel.first_half_width for panel in panels])[:, None]
    panel_end = np.array([panel.last_half_width for panel in panels])[:, None]
    # Half-widths a(eta) at the quadrature nodes of each panel, and their distances from the edge.
    edge_half_width = contact_half_widths[instant_numbers, None]
    half_widths = _distances_to_nodes(0.0, panel_begin, panel_end)
    distance_from_edge = _distances_to_nodes(
        edge_half_width, panel_begin, panel_end
    )  # a(eta) - a(P)
    loads = contact.load(half_widths)
    slopes_at_nodes = np.empty_like(loads)  # M'
    for panel_number, panel in enumerate(panels):
        slopes_at_nodes[panel_number] = panel.slope(loads[panel_number])
    # RULE_FOR_INVERSE_ROOTS: quadrature on a range of length 1, with nodes crowded at both ends.
    load_steps = (
        contact.stiffness(half_widths) * (panel_end - panel_begin) * RULE_FOR_INVERSE_ROOTS.weight
    )  # d eta
    panel_integrals = (
        load_steps
        * slopes_at_nodes
        / np.sqrt(-distance_from_edge * (2 * edge_half_width + distance_from_edge))
    ).sum(axis=1)
    sums_over_panels = np.bincount(
        instant_numbers, weights=panel_integrals, minlength=len(instants_in_contact)
    )
    return np.asarray(2 / math.pi * sums_over_panels)


def _panels_of_curves(
    contact: SymmetricContact,
    snapshot: Snapshot,
    instants_in_contact: Indices,
    contact_half_widths: Array,
) -> list[_Panel]:
    """Panels of half-widths between kinks of the memory curve M(eta) of each instant in contact,
    also cut at corners of the profile. M is the tangential force of the flat punches up to the load
    eta.

    Parameters
    ----------
    contact
        half-widths a(P) of the profile on half-planes
    instants_in_contact
        (m,) numbers of the instants in the `snapshot`, which holds M of several instants; a panel
        counts its instant among these
    contact_half_widths
        (m,) half-widths a(P) of the contact then [length]
    """
    instant_numbers: list[int] = []
    lower_loads: list[float] = []
    upper_loads: list[float] = []
    slope_functions: list[Slope] = []

    # The parts of M between two kinks, each with its loads and its slope M' as a function of eta.
    for instant_number, snapshot_number in enumerate(instants_in_contact.tolist()):
        for lower_load, upper_load, slope_function in _curve_parts(snapshot, snapshot_number):
            instant_numbers.append(instant_number)
            lower_loads.append(lower_load)
            upper_loads.append(upper_load)
            slope_functions.append(slope_function)
    begin_half_widths = np.atleast_1d(contact.half_width(np.array(lower_loads)))

    # The half-width at P is the edge to the last digit: one digit more or less would move the
    # integral of the root by 1e-8.
    edge_half_width = contact_half_widths[instant_numbers]
    reaches_edge = np.array(upper_loads) == snapshot.load[instants_in_contact][instant_numbers]
    half_width_at_upper_load = np.minimum(
        contact.half_width(np.array(upper_loads)), edge_half_width
    )
    end_half_widths = np.where(reaches_edge, edge_half_width, half_width_at_upper_load)
    return [
        _Panel(instant_number, panel_begin, panel_end, slope_function)
        for instant_number, least_half_width, largest_half_width, slope_function in zip(
            instant_numbers,
            begin_half_widths.tolist(),
            end_half_widths.tolist(),
            slope_functions,
            strict=True,
        )
        for panel_begin, panel_end in _panels_between(contact, least_half_width, largest_half_width)
    ]


# ----------------------------------------------- from tractions, where there is no one memory curve
def _answers_with_tractions(
    source: ContactSolution | Scene | str | Path, times: Array
) -> list[tuple[ContactSolution, int]]:
    """For each time a half-plane solution that has pressure and shear then, and the number of its
    instant: the source itself where it has enough points in the contact, or a new solution.

    New solutions have points across several of the contacts, and close to the edges of all.
    """
    # Key: time. Value: a solution, and the number (row) of the instant in it.
    answers: dict[float, tuple[ContactSolution, int]] = {}
    if isinstance(source, ContactSolution):
        scene = source.scene
        answers = _rows_with_tractions(source, times)
    else:
        scene = scene_of(source)
    missing_times = np.array(sorted(set(times.tolist()) - answers.keys()))
    if len(missing_times):
        # At most 20 instants in one solution.
        block_count = math.ceil(len(missing_times) / _INSTANTS_AT_ONCE)
        for times_at_once in np.array_split(missing_times, block_count):
            # The points are placed by the edges of contact, which follow from the loads alone.
            contact_edges = _contact_edges_at(scene, times_at_once)
            order_by_length = np.argsort(contact_edges[:, 1] - contact_edges[:, 0])
            places = _places_for_tractions(contact_edges[order_by_length])
            answer = solve(scene, x=places, time=times_at_once, fields=("pressure", "shear"))
            answers |= {time: (answer, row) for row, time in enumerate(times_at_once.tolist())}
    return [answers[time] for time in times.tolist()]


def _contact_edges_at(scene: Scene, times: Array) -> Array:
    """Left and right edge of the contact at n times of the load path, (n, 2) [length]. They follow
    from P and the tilt then. A time outside the path counts as its start or end.
    """
    path_loads, profile = path_loads_and_contact(scene)
    normal_load, _, _, tilt = path_loads.loads_at(times)
    centre, half_width = profile.centre_and_half_width_under(normal_load, tilt)
    return np.stack([centre - half_width, centre + half_width], axis=-1)


def _rows_with_tractions(
    answer: ContactSolution, times: Array
) -> dict[float, tuple[ContactSolution, int]]:
    """By time, the answer and the number of its instant, for those `times` that the answer covers.

    It covers an instant if it has pressure and shear then at 60 points of the contact or more, or
    if there is no contact. Empty where pressure or shear is NaN anywhere in the answer.
    """
    if not (np.isfinite(answer.pressure).all() and np.isfinite(answer.shear).all()):
        return {}
    rows = np.argmin(np.abs(answer.time[:, None] - times), axis=0)
    places_in_contact = np.sum(answer.pressure[rows] > 0, axis=1)
    has_enough_places = (places_in_contact >= _FEWEST_PLACES_IN_CONTACT) | (
        answer.normal_load[rows] <= 0
    )
    # Times differ by at most 1e-9 of themselves.
    has_instant = np.abs(answer.time[rows] - times) <= 1e-9 * np.abs(times)
    time_numbers = np.flatnonzero(has_enough_places & has_instant)
    return {
        float(times[time_number]): (answer, int(rows[time_number])) for time_number in time_numbers
    }


def _places_for_tractions(edges: Array) -> Array:
    """Places x, ascending [length], at which tractions are to be solved for: across at most four of
    the n contacts with the given edges, and close to the edges of all.

    `edges` (n, 2) are left and right edge of each contact, in the order of their lengths.
    """
    # The shortest, the longest and two between; 601 places across each.
    contact_numbers = np.unique(
        np.linspace(0, len(edges) - 1, _MOST_CONTACTS_WITH_PLACES).round().astype(int)
    )
    chosen_edges = edges[contact_numbers]
    cosines = np.cos(np.linspace(0, math.pi, _PLACE_COUNT_ACROSS_CONTACT))
    places_across = chosen_edges.mean(axis=1)[:, None] - np.diff(chosen_edges) / 2 * cosines
    # Distances from each edge: 1e-7 to 2.5e-2 of the contact's length.
    inwards = np.array([[1.0], [-1.0]])
    places_at_edges = (
        edges[:, :, None] + np.diff(edges)[:, :, None] * inwards * _WIDTH_SHARES_FROM_EDGE
    )
    return np.unique(np.concatenate([places_across.ravel(), places_at_edges.ravel()]))


def _bulk_stresses(answers: list[tuple[ContactSolution, int]]) -> Array:
    """Bulk stress of the lower and the upper body at the instant of each answer, (n, 2) [stress],
    tension positive.

    `answers` are pairs of a solution and the number (row) of the instant in it. 0 where the
    solution has no bulk stress.
    """
    stresses = np.zeros((len(answers), 2))
    for answer_number, (answer, row) in enumerate(answers):
        if answer.bulk_stress_lower is not None:
            stresses[answer_number, 0] = answer.bulk_stress_lower[row]
        if answer.bulk_stress_upper is not None:
            stresses[answer_number, 1] = answer.bulk_stress_upper[row]
    return stresses


# q/(f p) (n, k) of a solution on grids, at its instants and points, by coarse grids: cached as long
# as the solution exists.
_coarse_ratio_by_answer: WeakKeyDictionary[ContactSolution, RatioOnGrids] = WeakKeyDictionary()


def _ratio_on_coarse_grids(
    answer: ContactSolution, path_loads: PathLoads, profile: TiltedProfile
) -> RatioOnGrids | None:
    """q/(f p) at the n instants and k points of an answer, by grids of half as many cells and
    increments, along as many cycles; None where the answer is not from grids, NaN where the coarse
    ones do not follow its path. It is followed once.

    Parameters
    ----------
    answer
        half-plane solution
    path_loads
        P, Q, bulk strain and tilt of its scene over time
    profile
        its gap, as a contact under load and tilt
    """
    if "grids" not in answer.work.counts:
        return None
    if answer not in _coarse_ratio_by_answer:
        scene = answer.scene
        # Half of the usual 160 cells across the contact, and of 320 increments a cycle.
        request = GridRequest(
            most_cycles=answer.work.counts["cycles_solved"],
            cells=CELLS_ACROSS_CONTACT // 2,
            increments=INCREMENTS_PER_CYCLE // 2,
        )
        try:
            coarse_ratio = friction_ratio_on_grids(
                path_loads,
                profile,
                scene.profile.height,
                scene.friction.coefficient,
                answer.x,
                answer.time,
                request,
            )
        except InputError:  # near sliding all of the coarse cells may slip
            nowhere_known = np.full((len(answer.time), len(answer.x)), np.nan)
            coarse_ratio = RatioOnGrids(nowhere_known, math.nan)
        _coarse_ratio_by_answer[answer] = coarse_ratio
    return _coarse_ratio_by_answer[answer]


def _edge_tensions_of_answer(
    answer: ContactSolution,
    row: int,
    profile: TiltedProfile,
    coarse_grids: RatioOnGrids | None = None,
) -> tuple[Array, Array]:
    """Stress s_xx of the lower face at the left and the right edge of contact, without the bulk
    stress, and its uncertainty, (2,) each [stress].

    The stress is +-(2/pi) int q/|x - edge| dx; tension is positive. With x = middle - half_width
    cos(phi) that is the mean over phi of 2 q cot(phi/2) at the left edge, of -2 q tan(phi/2) at the
    right one.

    The uncertainty is the root of a sum of squares of errors:

    - a third of the change if half of the points are used, as q/p is linear between points;
    - the tension of a slip zone narrower than a cell, or than the distance of the first point;
    - for an answer from grids, the change by coarse grids, NaN where these do not follow its path;
    - for it also a fraction of the stated error of the shear;
    - for other answers 1e-3 of f times the largest pressure.

    Stress and uncertainty are 0 where no point is in contact.

    Parameters
    ----------
    answer, row
        half-plane solution, and the number of its instant
    profile
        the gap, as a contact under load and tilt
    coarse_grids
        q/(f p) at the instants and points of the answer by grids of cells twice as wide; None of
        other answers
    """
    pressure_at_points = answer.pressure[row]
    points_in_contact = np.flatnonzero(pressure_at_points > 0)
    if not len(points_in_contact):
        return np.zeros(2), np.zeros(2)
    friction = answer.scene.friction.coefficient

    # Angles phi and 512 places across the contact, with the exact f p there.
    phi, places = _places_across(answer, row, _PLACES_OF_TENSION)
    friction_limit = friction * _pressure_across(answer, row, profile, places)
    # Tension at the left and at the right edge by q = f p, for each place: (2, 512).
    tension_of_sliding = 2 * friction_limit * np.stack([1 / np.tan(phi / 2), -np.tan(phi / 2)])

    def tensions_by(friction_ratio: Array, points: Indices) -> Array:
        """The stress at both edges from q/(f p) at some of the points, (2,) [stress]."""
        ratio_at_places = np.interp(places, answer.x[points], friction_ratio[points])
        return np.mean(tension_of_sliding * ratio_at_places, axis=1)

    limit_at_points = friction * np.where(pressure_at_points > 0, pressure_at_points, math.inf)
    friction_ratio = answer.shear[row] / limit_at_points
    tension = tensions_by(friction_ratio, points_in_contact)
    changes_by_points = [
        np.abs(tensions_by(friction_ratio, half_of_points) - tension)
        for half_of_points in (points_in_contact[::2], points_in_contact[1::2])
        if len(half_of_points)
    ]
    error_between_points = _ERROR_OVER_CHANGE_BY_POINTS * np.max(changes_by_points, axis=0)

    largest_friction = friction * float(pressure_at_points.max())
    cell_width = 0.0
    change_by_grids = np.zeros(2)
    error_by_shear = _TENSION_ERROR_SHARE_BETWEEN_PLACES * largest_friction
    if coarse_grids is not None:
        cell_width = coarse_grids.cell_width / 2
        coarse_tension = tensions_by(coarse_grids.friction_ratio[row], points_in_contact)
        change_by_grids = coarse_tension - tension
        share_of_shear_error = _TENSION_ERROR_OVER_SHEAR_ERROR * answer.record.errors.get(
            "shear", 0.0
        )
        error_by_shear = share_of_shear_error * largest_friction

    # Tension of slip zones beside either edge: points and places by their distance from it.
    tension_of_slip_zones = np.array(
        [
            _tension_of_narrow_slip_zone(
                np.abs(answer.x[points_in_contact] - contact_edge),
                friction_ratio[points_in_contact],
                cell_width,
                np.abs(places - contact_edge),
                np.abs(tension_of_sliding[edge_number]),
            )
            for edge_number, contact_edge in enumerate(answer.contact_edges[row].tolist())
        ]
    )
    uncertainty = np.sqrt(
        error_between_points**2 + change_by_grids**2 + error_by_shear**2 + tension_of_slip_zones**2
    )
    return tension, uncertainty


def _tension_of_narrow_slip_zone(
    distances: Array,
    friction_ratio: Array,
    cell_width: float,
    distances_of_places: Array,
    tension_of_sliding: Array,
) -> float:
    """Estimate of the tension that a narrow slip zone may add at an edge of contact [stress]. The
    zone has just begun there, and is too narrow for the cells and points of an answer.

    Beside an edge p = K sqrt(d) at the distance d. Where a load has turned, a slip zone of width z
    changes q by -F (sqrt(d) - sqrt(d - z)), with F = f K |s - r|: r is q/(f p) before, s = +-1 its
    value in slip. Farther in that is F z/(2 sqrt(d)); of the tension it is 2 F sqrt(z).

    The answer holds only what the zone changes farther in, which grows as z. So the tension grows
    as the root of two factors:

    - q/(f p) at the edge minus that at the width of a cell farther in, in size;
    - |s - r|, s being the sign of that difference.

    Where the cell beside the edge slips that way already, the zone is wider than the cell, and
    nothing is added.

    Parameters
    ----------
    distances, friction_ratio
        (k,) distances of points in contact from the edge [length], and q/(f p) there
    cell_width
        of the grids; 0 without grids [length]
    distances_of_places, tension_of_sliding
        (m,) distances of places across the contact from the edge, and the tension by q = f p there,
        whose mean is that of the whole contact [stress]
    """
    # numbers of the points from the edge inwards
    order_from_edge = np.argsort(distances)
    # Nothing is known nearer to the edge than the nearest point, and within a cell.
    unresolved_width = cell_width + float(distances[order_from_edge[0]])
    ratio_at_edge, ratio_farther_in = np.interp(
        [0.0, unresolved_width], distances[order_from_edge], friction_ratio[order_from_edge]
    )
    ratio_difference = float(ratio_at_edge - ratio_farther_in)
    ratio_left_to_slip = 1 - math.copysign(1.0, ratio_difference) * float(ratio_at_edge)
    tension_of_cell = float(np.mean(tension_of_sliding * (distances_of_places < unresolved_width)))
    share_of_sliding_tension = math.sqrt(abs(ratio_difference) * max(ratio_left_to_slip, 0.0) / 2)
    return _TENSION_OF_NARROW_SLIP_ZONE * tension_of_cell * share_of_sliding_tension


def _places_across(answer: ContactSolution, row: int, count: int) -> tuple[Array, Array]:
    """Angles phi between 0 and pi, and places middle - half_width cos(phi) [length] across the
    contact of an answer at the instant number `row`, (count,) each, from the left edge on.
    """
    left_edge, right_edge = answer.contact_edges[row]
    phi = math.pi * (np.arange(count) + 0.5) / count
    return phi, (left_edge + right_edge) / 2 - (right_edge - left_edge) / 2 * np.cos(phi)


def _pressure_across(
    answer: ContactSolution, row: int, profile: TiltedProfile, places: Array
) -> Array:
    """Exact pressure at places x (n,) in the contact of an answer at the instant number `row`, (n,)
    [stress]. `profile` is the gap, as a contact whose pressure follows from centre and half-width.
    """
    edges = answer.contact_edges[row]
    return profile.pressure_over(places, edges.mean(keepdims=True), np.diff(edges) / 2)[0]


def _stress_by_sine_series(
    answer: ContactSolution, row: int, profile: TiltedProfile, x: Array, y: Array, side: float
) -> Array:
    """Stress s_xx, s_yy, s_xy of a body below y = 0 at places x, y (n,), (n, 3), by sine series of
    the tractions of an answer at the instant number `row`; without the bulk stress.

    Parameters
    ----------
    answer, row
        half-plane solution with pressure and shear, and the number of its instant
    profile
        the gap, as a contact whose pressure follows from centre and half-width
    x, y
        (n,) places [length], y <= 0
    side
        1 for the lower body, -1 for the upper one, whose shear acts the other way

    # notation: zeta = (x + i y - middle)/half-width, omega = zeta - sqrt(zeta^2 - 1); N, T
    #           potentials of pressure and shear, N = pi sum A_k omega^k for p = sum A_k sin(k phi)

    p is exact, q/p linear between the points of the answer. The series of p and q across the
    contact are summed by Horner's rule. The stress is 0 where no point of the answer is in contact.
    """
    is_in_contact = answer.pressure[row] > 0
    if not is_in_contact.any():
        return np.zeros((len(x), 3))
    left_edge, right_edge = answer.contact_edges[row]
    middle = (left_edge + right_edge) / 2
    half_width = (right_edge - left_edge) / 2

    # As many places as terms, with the exact pressure there.
    # _SERIES_TERMS: 2048.
    _, places = _places_across(answer, row, _SERIES_TERMS)
    pressure = _pressure_across(answer, row, profile, places)
    ratio_at_points = answer.shear[row, is_in_contact] / answer.pressure[row, is_in_contact]
    shear = pressure * np.interp(places, answer.x[is_in_contact], ratio_at_points)

    # phi of the sine series is counted from the right edge, so that places are reversed.
    # A_k of pressure and of shear, (2, terms).
    sine_series = scipy.fft.dst(np.stack([pressure, side * shear])[:, ::-1], 2) / _SERIES_TERMS
    # Summed at the mirror image x - i y, above the cut of the root. The coefficients are real, so
    # that the conjugate of the sum is its value at x + i y.
    zeta = (x - middle + 0j) / half_width
    zeta.imag = np.abs(y) / half_width
    root_of_zeta = np.sqrt(zeta - 1) * np.sqrt(zeta + 1)
    omega = zeta - root_of_zeta
    # Sums of N and T over pi, then those with k A_k in the place of A_k for their derivatives.
    series_sums = np.zeros((4, len(x)), dtype=complex)
    with np.errstate(divide="ignore"):
        log_of_omega = np.log(np.minimum(np.abs(omega), 1 - 1e-12))
        terms_needed = np.minimum(
            np.ceil(math.log(_NEGLIGIBLE_POWER) / log_of_omega), _SERIES_TERMS
        )

    # Terms of which |omega|^k is above 1e-17; points with most terms first.
    order_by_terms = np.argsort(-terms_needed, kind="stable")
    omega = omega[order_by_terms]
    points_with_term = np.searchsorted(
        -terms_needed[order_by_terms], -np.arange(1, _SERIES_TERMS + 1), side="right"
    )
    for k in range(_SERIES_TERMS, 0, -1):  # Horner's rule, from where omega^k counts
        n_points = points_with_term[k - 1]
        series_sums[:2, :n_points] = (
            series_sums[:2, :n_points] + sine_series[:, k - 1, None]
        ) * omega[:n_points]
        series_sums[2:, :n_points] = (
            series_sums[2:, :n_points] + k * sine_series[:, k - 1, None]
        ) * omega[:n_points]
    series_sums[:, order_by_terms] = series_sums.copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        # y N', y T'; d omega/dz = -omega/(half_width root_of_zeta)
        derivatives_times_y = np.where(
            y == 0, 0.0, -y * (series_sums[2:] / (half_width * root_of_zeta)).conj()
        )
    return _stress_from_potentials(
        *math.pi * series_sums[:2].conj(), *math.pi * derivatives_times_y
    )


def _stress_from_potentials(
    normal_potential: Complex,
    tangential_potential: Complex,
    y_normal_derivative: Complex,
    y_tangential_derivative: Complex,
) -> Array:
    """Stresses s_xx, s_yy, s_xy of a body below y = 0 at points (n,), (n, 3), by Muskhelishvili's
    potentials N of the pressure and T of the shear.

        pi s_xx = -Im N - 2 Re T - y (Re N' - Im T')
        pi s_yy = -Im N          + y (Re N' - Im T')
        pi s_xy =  Im T          + y (Im N' + Re T')

    N and T are functions of z = x + i y. `y_normal_derivative` is y N', `y_tangential_derivative`
    y T', (n,) complex each.
    """
    stress_by_depth = y_normal_derivative.real - y_tangential_derivative.imag
    stress_by_pressure = -normal_potential.imag
    components = (
        stress_by_pressure - 2 * tangential_potential.real - stress_by_depth,
        stress_by_pressure + stress_by_depth,
        tangential_potential.imag + y_normal_derivative.imag + y_tangential_derivative.real,
    )
    return np.stack(components, axis=-1) / math.pi


def _curve_parts(snapshot: Snapshot, instant_number: int) -> Iterator[tuple[float, float, Slope]]:
    """Lower load, upper load and slope M' of each smooth part of the memory curve M(eta) at one
    instant, from the normal load P down to 0.

    The contact is a superposition of flat punches: those up to the load eta make up the contact
    under P = eta. M(eta) is the tangential force that they carry. From the load at the stick edge
    to P the contact slips: M' is f or -f. Below that edge the curve consists of linked pieces.

    The `snapshot` holds several instants; `instant_number` is that of the wanted one. It has

    - `load`: P of each;
    - `slip_zone_load`: P minus the load at the stick edge of each;
    - `direction`: of slip, 1 forward, -1 in reverse, 0 for none;
    - `piece_number`: of each, the index in `sticking_pieces` of the piece at the stick edge.
    """
    load = float(snapshot.load[instant_number])
    stick_edge_load = float(snapshot.load[instant_number] - snapshot.slip_zone_load[instant_number])
    # The slip zone: M' is f in the direction of slip.
    if stick_edge_load < load:
        slope = float(snapshot.direction[instant_number] * snapshot.friction)
        yield max(stick_edge_load, 0.0), load, lambda eta: np.full(eta.shape, slope)
    piece_at_edge = snapshot.sticking_pieces[snapshot.piece_number[instant_number]]
    for piece in pieces(piece_at_edge):  # from there down
        if piece.bottom_load < stick_edge_load:
            upper_load = min(piece.top_load, stick_edge_load)
            yield piece.bottom_load, upper_load, _slope_of_piece(piece, snapshot.friction)


def _slope_of_piece(piece: CurvePart, friction: float) -> Slope:
    """Slope M'(eta) on a piece of the memory curve M, the tangential force of the flat punches up
    to the load eta. On a piece that was appended along an arc of the load path it is clipped to
    +-f, `friction`.
    """
    if piece.arc_times is None:
        return piece.slope_at
    return lambda eta: np.asarray(np.clip(piece.slope_at(eta), -friction, friction))


def _potentials(
    contact: SymmetricContact,
    curve_parts: Iterator[tuple[float, float, Slope]],
    x: Array,
    y: Array,
) -> Complex:
    """Muskhelishvili's potentials N of pressure and T of shear, and their derivatives, at x + i y,
    y <= 0: complex (4, n), summed over the flat punches of a contact.

    The memory curve M(eta) is the tangential force of the punches up to the load eta. The
    derivatives are left 0 on the face, where they only occur times y. Places with x < 0 follow by
    symmetry.

    Parameters
    ----------
    contact
        half-widths a(P) of the profile
    curve_parts
        lower load, upper load and slope M' of each smooth part of M; M' is the tangential load of a
        punch per normal load
    x, y
        (n,) places [length]
    """
    potentials = np.zeros((4, len(x)), dtype=complex)
    distance_from_middle = np.abs(x)
    for lower_load, upper_load, slope in curve_parts:
        begin_half_width = float(contact.half_width(lower_load))
        end_half_width = float(contact.half_width(upper_load))
        for panel_ends in _panels_between(contact, begin_half_width, end_half_width):
            _add_panel_of_punches(potentials, contact, slope, panel_ends, distance_from_middle, y)
    potentials[:2, x < 0] = -potentials[:2, x < 0].conj()
    potentials[2:, x < 0] = potentials[2:, x < 0].conj()
    return potentials


def _panels_between(
    contact: SymmetricContact, least_half_width: float, largest_half_width: float
) -> Iterator[tuple[float, float]]:
    """First and last half-width of each panel into which the flat punches between two half-widths
    are divided [length]: cut where the profile has a corner (`corner_half_widths`).
    """
    inner_corners = (
        corner_half_width
        for corner_half_width in contact.corner_half_widths
        if least_half_width < corner_half_width < largest_half_width
    )
    for first_half_width, last_half_width in pairwise(
        [least_half_width, *inner_corners, largest_half_width]
    ):
        if last_half_width > first_half_width:
            yield first_half_width, last_half_width


def _distances_to_nodes(place: ArrayLike, begin: ArrayLike, end: ArrayLike) -> Array:
    """Distances from `place` of the quadrature nodes between `begin` and `end`, without
    cancellation at either end; a new last axis is that of the nodes.

    The nodes are crowded at both ends, for integrands with inverse roots there. The arrays
    broadcast.
    """
    # RULE_FOR_INVERSE_ROOTS: quadrature rule on a range of length 1.
    rule = RULE_FOR_INVERSE_ROOTS
    # Distances of the nodes from 0 and from 1, on a range of length 1.
    span_length = np.subtract(end, begin)
    distance_from_begin = np.subtract(begin, place) + span_length * rule.distance_from_begin
    distance_from_end = np.subtract(end, place) - span_length * rule.distance_from_end
    return np.where(rule.distance_from_begin < 0.5, distance_from_begin, distance_from_end)


def _add_panel_of_punches(
    potentials: Complex,
    contact: SymmetricContact,
    slope: Slope,
    ends: tuple[float, float],
    x: Array,
    y: Array,
) -> None:
    """Add to Muskhelishvili's potentials (4, n) at places x >= 0, y <= 0 (n,) a panel of flat
    punches: those with half-widths between the two `ends` [length].

    The potentials are N of pressure, T of shear and their derivatives. `slope` is their tangential
    load per normal load, M', as a function of the load eta. `contact` gives eta of a half-width.
    The potential of a punch is singular at |x| equal to its half-width. The panel is cut there for
    points x between its ends.
    """
    begin_half_width, end_half_width = ends
    panel_width = end_half_width - begin_half_width
    rule = RULE_FOR_INVERSE_ROOTS
    # A rule for inverse roots at both ends: distances of its nodes from 0 and from 1, and weights.
    # Nodes in the lower half of the panel are placed from its begin, the others from its end.
    is_in_lower_half = rule.distance_from_begin < 0.5
    half_widths = _distances_to_nodes(0.0, begin_half_width, end_half_width)

    # Normal and tangential load at each node, (2, nodes).
    loads_of_panel = _loads_of_punches(contact, slope, half_widths, panel_width * rule.weight)
    is_in_panel = (x > begin_half_width) & (x < end_half_width)
    # _KERNELS_AT_ONCE: a million pairs of point and node, which bounds the memory.
    points_at_once = _KERNELS_AT_ONCE // len(rule.distance_from_begin)

    # Points beside the panel, many at once.
    points_beside = np.flatnonzero(~is_in_panel)
    for point_numbers in np.array_split(points_beside, 1 + len(points_beside) // points_at_once):
        distance_to_punch = _distances_to_nodes(
            x[point_numbers, None], begin_half_width, end_half_width
        )
        _add_punches(potentials, point_numbers, loads_of_panel, distance_to_punch, x, y)

    # Points whose |x| is a half-width of the panel: the panel is cut there into two parts.
    points_in_panel = np.flatnonzero(is_in_panel)
    for point_numbers in np.array_split(
        points_in_panel, 1 + len(points_in_panel) // points_at_once
    ):
        x_of_points = x[point_numbers, None]
        # Part of narrower punches, sign -1, then part of wider ones, sign 1.
        for sign, part_end_half_width in ((-1.0, begin_half_width), (1.0, end_half_width)):
            part_width = sign * (part_end_half_width - x_of_points)
            distance_to_punch = sign * part_width * rule.distance_from_begin
            half_widths = np.where(
                is_in_lower_half,
                x_of_points + distance_to_punch,
                part_end_half_width - sign * part_width * rule.distance_from_end,
            )
            loads_of_part = _loads_of_punches(contact, slope, half_widths, part_width * rule.weight)
            _add_punches(potentials, point_numbers, loads_of_part, distance_to_punch, x, y)


def _loads_of_punches(
    contact: SymmetricContact, slope: Slope, half_widths: Array, node_weights: Array
) -> Array:
    """Normal load d eta and tangential load M' d eta that belong to the flat punches at quadrature
    nodes, (2, ...) [force per thickness].

    `slope` is M' as a function of the load eta. `half_widths` (...) are those of the punches,
    `node_weights` (...) the weights of the nodes as half-widths [length]. `contact.stiffness` is d
    eta/da.
    """
    load_steps = contact.stiffness(half_widths) * node_weights
    return np.stack([load_steps, load_steps * slope(contact.load(half_widths))])


def _add_punches(
    potentials: Complex,
    point_numbers: NDArray[np.intp],
    punch_loads: Array,
    distance_to_punch: Array,
    x: Array,
    y: Array,
) -> None:
    """Add flat punches to Muskhelishvili's potentials (4, n) at some points: N of pressure, T of
    shear, and their derivatives with respect to z = x + i y.

    A punch of half-width a and unit load adds 1/sqrt(z^2 - a^2).

    Parameters
    ----------
    point_numbers
        (m,) numbers of the points
    punch_loads
        (2, nodes), or (2, m, nodes): normal and tangential load of the punches at the nodes
    distance_to_punch
        (m, nodes) a - x [length], of which z^2 - a^2 is formed without cancellation
    x, y
        (n,) places of all points [length]
    """
    x_of_points = x[point_numbers, None]
    y_of_points = y[point_numbers, None]
    # z^2 - a^2. Its imaginary part is -0 on the face, not 0: the root there is the limit from
    # inside the lower body.
    difference_of_squares = np.empty(distance_to_punch.shape, dtype=complex)
    difference_of_squares.real = (
        -distance_to_punch * (2 * x_of_points + distance_to_punch) - y_of_points * y_of_points
    )
    difference_of_squares.imag = 2 * x_of_points * -np.abs(y_of_points)
    # 1/sqrt(z^2 - a^2), (m, nodes); the sum over the nodes with the loads of the punches.
    inverse_root = 1 / np.sqrt(difference_of_squares)
    potentials[:2, point_numbers] += np.einsum(
        "...mn,mn->...m" if punch_loads.ndim == 3 else "kn,mn->km", punch_loads, inverse_root
    )
    # Derivatives -z/(z^2 - a^2)^(3/2) inside the body; on the face they are left 0.
    numbers_in_body = np.flatnonzero(y_of_points[:, 0] != 0)
    if len(numbers_in_body):
        inverse_root_cubed = inverse_root[numbers_in_body] / difference_of_squares[numbers_in_body]
        loads_in_body = punch_loads[:, numbers_in_body] if punch_loads.ndim == 3 else punch_loads
        z = (x_of_points + 1j * y_of_points)[numbers_in_body, 0]
        potentials[2:, point_numbers[numbers_in_body]] -= z * np.einsum(
            "...mn,mn->...m" if punch_loads.ndim == 3 else "kn,mn->km",
            loads_in_body,
            inverse_root_cubed,
        )
