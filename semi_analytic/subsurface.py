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
come from the tractions of the solution: with x = m + h cos(phi), p = sum A_k sin(k phi) and zeta =
(z - m)/h, N = pi sum A_k (zeta - sqrt(zeta^2 - 1))^k. The bulk stress of the body is added.

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
# given solution.
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

    It includes the bulk stress. The coupling of unlike materials is neglected.

    Parameters
    ----------
    source
        the scene, its name or file, or a solution of it
    x, y
        (n_points,) coordinates of the points, or one number for all [length]. y points from the
        lower body to the upper one: y <= 0 in the lower body, y >= 0 in the upper one, 0 on both
        faces
    instants
        (n_instants,) times of the load path
    body
        "lower" or "upper"

    Returns
    -------
    Array
        (n_instants, n_points, 4) s_xx, s_yy, s_xy and s_zz = nu (s_xx + s_yy), tension positive
        [stress]. Infinite at the tip of a sharp wedge. The error is about 1e-11 of the largest
        pressure p0. With bulk stress, tilt or unequal sides it is about 1e-3 f p0, or the error of
        the shear traction of `solve` where that is larger.

    Raises
    ------
    InputError
        For a `body` of another name, a point outside it, a time outside the path, or numbers that
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
    x_of_points, y_of_points, times = _points_and_times(x, y, instants)
    if body not in ("lower", "upper"):
        raise InputError(f"body: {body!r} is neither 'lower' nor 'upper'")
    sign_of_body = 1.0 if body == "lower" else -1.0
    # The upper body is computed as its mirror image, which lies at y <= 0 as the lower body does.
    # In the mirror image the shear traction and the stress s_xy have the other sign.
    mirrored_y = sign_of_body * y_of_points
    if np.any(mirrored_y > 0):
        raise InputError(
            f"y: {sign_of_body * float(np.max(mirrored_y)):.6g} is outside the {body}"
            " body; y points out of the lower one"
        )

    stresses = np.zeros((len(times), len(x_of_points), 4))
    if scene.unsymmetric:  # bulk stress, tilt or unequal sides
        solutions_and_rows = _solutions_with_tractions(source, times)
        stresses[..., :3] = _stresses_by_tractions(
            scene, solutions_and_rows, x_of_points, mirrored_y, sign_of_body
        )
        stresses[..., 0] += _bulk_stresses(solutions_and_rows)[:, int(body == "upper"), None]
    else:
        stresses[..., :3] = _stresses_by_memory_curves(
            scene, times, x_of_points, mirrored_y, sign_of_body
        )
    stresses[..., 2] *= sign_of_body
    poisson_ratio = getattr(scene.material, body).poisson_ratio
    stresses[..., 3] = poisson_ratio * (stresses[..., 0] + stresses[..., 1])
    return stresses


def _stresses_by_memory_curves(
    scene: Scene, times: Array, x: Array, y: Array, sign_of_body: float
) -> Array:
    """Stress s_xx, s_yy, s_xy of a body below y = 0, of a scene without bulk stress, tilt and
    unequal sides: (n, k, 3) at n times and k points x, y [stress]. 0 out of contact.

    The contact is a superposition of flat punches. The memory curve M(eta) is the tangential force
    of those up to the normal load eta. Both give Muskhelishvili's potentials of the tractions.

    `sign_of_body` is 1 for the lower body. It is -1 for the mirror image of the upper one, on which
    the shear traction acts the other way.
    """
    # Normal contact P(a) of the profile; P (`load`) and M at each time.
    contact, snapshot = memory_at(scene, times)
    stresses = np.zeros((len(times), len(x), 3))
    for instant_number in np.flatnonzero(snapshot.load > 0).tolist():
        normal_potential, tangential_potential, normal_derivative, tangential_derivative = (
            _potentials(contact, _curve_parts(snapshot, instant_number), x, y)
        )
        stresses[instant_number] = _stress_from_potentials(
            normal_potential,
            sign_of_body * tangential_potential,
            y * normal_derivative,
            y * sign_of_body * tangential_derivative,
        )
    return stresses


def _stresses_by_tractions(
    scene: Scene,
    solutions_and_rows: list[tuple[ContactSolution, int]],
    x: Array,
    y: Array,
    sign_of_body: float,
) -> Array:
    """Stress s_xx, s_yy, s_xy of a body below y = 0 from the tractions of half-plane solutions,
    without the bulk stress: (n, k, 3) at n instants and k points x, y [stress].

    `solutions_and_rows` has for each instant a solution, and the row of the instant in its fields.
    `sign_of_body` is 1 for the lower body. It is -1 for the mirror image of the upper one, on which
    the shear traction acts the other way.
    """
    # normal contact of the profile, which gives its exact pressure under any tilt, also under none
    _, tilted_contact = path_loads_and_contact(scene)
    stresses = np.zeros((len(solutions_and_rows), len(x), 3))
    for place_in_list, (solution, row) in enumerate(solutions_and_rows):
        stresses[place_in_list] = _stress_by_sine_series(
            solution, row, tilted_contact, x, y, sign_of_body
        )
    return stresses


def _points_and_times(
    x: ArrayLike, y: ArrayLike, instants: ArrayLike
) -> tuple[Array, Array, Array]:
    """Checked coordinates x and y of n points, (n,) each [length], and times (m,) of the instants.

    A single x or y is that of all points.

    Raises
    ------
    InputError
        Where x, y or `instants` is missing, or x and y differ in length and neither is single.
    """
    # `checked_numbers`: a caller's finite numbers as an array, or None where none are given.
    x_of_points = checked_numbers(x, "x")
    y_of_points = checked_numbers(y, "y")
    times = checked_numbers(instants, "instants")
    if x_of_points is None or y_of_points is None or times is None:
        raise InputError("stress: x, y and instants are needed")
    if len(x_of_points) != len(y_of_points) and min(len(x_of_points), len(y_of_points)) > 1:
        raise InputError(
            f"x and y: {len(x_of_points)} and {len(y_of_points)} places; give as many of both"
        )
    x_of_points, y_of_points = np.broadcast_arrays(x_of_points, y_of_points)
    return x_of_points, y_of_points, times


def edge_tension(
    source: ContactSolution | Scene | str | Path, instants: ArrayLike
) -> tuple[Array, Array]:
    """Stress s_xx along both faces at the edges of contact, where fretting cracks start, and its
    uncertainty [stress], at instants of the load path; tension is positive.

    It includes the bulk stress. Without bulk stress, tilt and unequal sides it is +-(2/pi) int_0^P
    M'(eta) d eta / sqrt(a(P)^2 - a(eta)^2). There a is the half-width of the contact, and M(eta)
    the tangential force carried by the flat punches up to the load eta. For Q > 0 at constant P it
    is tension at the left edge of the lower body and at the right edge of the upper body.

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
        stress alone. An uncertainty is NaN where the coarse grids that estimate it do not converge

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
    if scene.unsymmetric:  # bulk stress, tilt or unequal sides
        solutions_and_rows = _solutions_with_tractions(source, times)
        lower_tensions, edge_uncertainties = _edge_tensions_by_tractions(scene, solutions_and_rows)
        bulk_stresses = _bulk_stresses(solutions_and_rows)
    else:
        lower_tensions, edge_uncertainties = _edge_tensions_by_memory_curves(scene, times)
        bulk_stresses = np.zeros((len(times), 2))
    # The shear traction acts on the upper body the other way.
    sign_of_body = np.array([[1.0], [-1.0]])
    values = sign_of_body * lower_tensions[:, None, :] + bulk_stresses[:, :, None]
    uncertainties = np.repeat(edge_uncertainties[:, None, :], 2, axis=1)
    return values, uncertainties


def _edge_tensions_by_tractions(
    scene: Scene, solutions_and_rows: list[tuple[ContactSolution, int]]
) -> tuple[Array, Array]:
    """Stress s_xx of the lower face at the left and right edge of contact, and its uncertainty, by
    the tractions of half-plane solutions at n instants: (n, 2) each [stress], without bulk stress.

    `solutions_and_rows` has for each instant a solution, and the number (row) of the instant in it.
    An uncertainty is NaN where the coarse grids that estimate it do not converge.
    """
    path_loads, tilted_contact = path_loads_and_contact(scene)
    tensions = np.zeros((len(solutions_and_rows), 2))
    uncertainties = np.zeros((len(solutions_and_rows), 2))
    for instant_number, (solution, row) in enumerate(solutions_and_rows):
        coarse_grids = _ratio_on_coarse_grids(solution, path_loads, tilted_contact)
        tensions[instant_number], uncertainties[instant_number] = _edge_tensions_of_solution(
            solution, row, tilted_contact, coarse_grids
        )
    return tensions, uncertainties


def _edge_tensions_by_memory_curves(scene: Scene, times: Array) -> tuple[Array, Array]:
    """Stress s_xx of the lower face at the left and right edge of contact, and its uncertainty, of
    a scene without bulk stress, tilt and unequal sides, at n times: (n, 2) each [stress].

    They follow from the memory curve M(eta) at each time: the tangential force of the flat punches
    up to the load eta, of whose superposition the contact consists. The uncertainty is the error of
    the quadrature, 1e-11 of P/a. Both are 0 out of contact.
    """
    # Normal contact P(a) of the profile; P (`load`) and M at each time.
    contact, snapshot = memory_at(scene, times)
    tensions = np.zeros((len(times), 2))
    uncertainties = np.zeros((len(times), 2))
    instants_in_contact = np.flatnonzero(snapshot.load > 0)
    # 128 instants at once bound the memory that the sums take.
    for first_index in range(0, len(instants_in_contact), _CURVES_AT_ONCE):
        instant_numbers = instants_in_contact[first_index : first_index + _CURVES_AT_ONCE]
        normal_load = snapshot.load[instant_numbers]
        half_width = np.atleast_1d(contact.half_width(normal_load))
        left_tension = _edge_tensions_of_curves(contact, snapshot, instant_numbers, half_width)
        # The contact is symmetric: what is tension at its left edge is compression at the right.
        tensions[instant_numbers] = left_tension[:, None] * [1.0, -1.0]
        uncertainties[instant_numbers] = (_ROUNDOFF_OF_TENSION * normal_load / half_width)[:, None]
    return tensions, uncertainties


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
    """Stress s_xx of the lower face at its left edge of contact at n instants in contact, without
    the bulk stress, (n,) [stress]: (2/pi) int_0^P M'(eta) d eta / sqrt(a(P)^2 - a(eta)^2).

    The contact is a superposition of flat punches of half-widths a(eta), 0 < eta <= P. M(eta), the
    memory curve of an instant, is the tangential force of those up to the normal load eta.

    Parameters
    ----------
    contact
        normal contact of the profile: its load P(a), and dP/da (`stiffness`)
    snapshot, instants_in_contact
        M of several instants, and the numbers (n,) of the wanted ones
    contact_half_widths
        (n,) half-widths a(P) of the contact then [length]
    """
    # Ranges of half-widths over which the integrand is smooth, each with its instant and its M'.
    panels = _panels_of_curves(contact, snapshot, instants_in_contact, contact_half_widths)
    panel_instants = np.array([panel.instant for panel in panels])
    first_half_width = np.array([panel.first_half_width for panel in panels])[:, None]
    last_half_width = np.array([panel.last_half_width for panel in panels])[:, None]
    contact_half_width = contact_half_widths[panel_instants, None]

    # Quadrature nodes of each panel, (panels, nodes): a(eta), a(eta) - a(P), eta, M'(eta), d eta.
    punch_half_width = _distances_to_nodes(0.0, first_half_width, last_half_width)
    half_width_difference = _distances_to_nodes(
        contact_half_width, first_half_width, last_half_width
    )
    punch_load = contact.load(punch_half_width)
    tangential_per_normal_load = np.empty_like(punch_load)
    for panel_number, panel in enumerate(panels):
        tangential_per_normal_load[panel_number] = panel.slope(punch_load[panel_number])
    panel_width = last_half_width - first_half_width
    load_increment = (
        contact.stiffness(punch_half_width) * panel_width * RULE_FOR_INVERSE_ROOTS.weight
    )

    # The root is that of a(P)^2 - a(eta)^2, from their difference without cancellation.
    panel_integrals = (
        load_increment
        * tangential_per_normal_load
        / np.sqrt(-half_width_difference * (2 * contact_half_width + half_width_difference))
    ).sum(axis=1)
    instant_integrals = np.bincount(
        panel_instants, weights=panel_integrals, minlength=len(instants_in_contact)
    )
    return np.asarray(2 / math.pi * instant_integrals)


def _panels_of_curves(
    contact: SymmetricContact,
    snapshot: Snapshot,
    instants_in_contact: Indices,
    contact_half_widths: Array,
) -> list[_Panel]:
    """Ranges (panels) of punch half-widths over which an integral with M'(eta) is smooth, of n
    instants in contact.

    M(eta), the memory curve of an instant, is the tangential force of the flat punches up to the
    normal load eta. A panel ends at a kink of M, or at a half-width with a corner of the profile.

    Parameters
    ----------
    contact
        normal contact of the profile, with half-widths a(P)
    snapshot, instants_in_contact
        M and P (`load`) of several instants, and the numbers (n,) of the wanted ones. The panels
        count their instants from 0 to n - 1
    contact_half_widths
        (n,) half-widths a(P) of the contact then [length]
    """
    # For each part of a curve between two kinks: its instant, its loads eta, and M' there.
    part_instants: list[int] = []
    lower_loads: list[float] = []
    upper_loads: list[float] = []
    slope_functions: list[Slope] = []
    for instant_number, row_of_snapshot in enumerate(instants_in_contact.tolist()):
        for lower_load, upper_load, slope_function in _curve_parts(snapshot, row_of_snapshot):
            part_instants.append(instant_number)
            lower_loads.append(lower_load)
            upper_loads.append(upper_load)
            slope_functions.append(slope_function)
    least_half_widths = np.atleast_1d(contact.half_width(np.array(lower_loads)))

    # A part that ends at P ends at a(P) to the last digit: one digit more or less would move the
    # integral of an inverse root by 1e-8.
    contact_half_width = contact_half_widths[part_instants]
    normal_load = snapshot.load[instants_in_contact][part_instants]
    largest_half_widths = np.where(
        np.array(upper_loads) == normal_load,
        contact_half_width,
        np.minimum(contact.half_width(np.array(upper_loads)), contact_half_width),
    )
    return [
        _Panel(instant_number, first_half_width, last_half_width, slope_function)
        for instant_number, least_half_width, largest_half_width, slope_function in zip(
            part_instants,
            least_half_widths.tolist(),
            largest_half_widths.tolist(),
            slope_functions,
            strict=True,
        )
        for first_half_width, last_half_width in _panels_between(
            contact, least_half_width, largest_half_width
        )
    ]


# ----------------------------------------------- from tractions, where there is no one memory curve
def _solutions_with_tractions(
    source: ContactSolution | Scene | str | Path, times: Array
) -> list[tuple[ContactSolution, int]]:
    """For each of n times a half-plane solution with pressure and shear then, and the number (row)
    of the instant in it.

    It is the `source` itself where that has 60 points in the contact then. For all other times the
    scene is solved, at points across several of the contacts, and close to the edges of all.
    """
    # by time
    solutions_and_rows: dict[float, tuple[ContactSolution, int]] = {}
    if isinstance(source, ContactSolution):
        scene = source.scene
        solutions_and_rows = _rows_with_tractions(source, times)
    else:
        scene = scene_of(source)
    missing_times = np.array(sorted(set(times.tolist()) - solutions_and_rows.keys()))
    if len(missing_times):
        # At most 20 instants in one solution.
        n_blocks = math.ceil(len(missing_times) / _INSTANTS_AT_ONCE)
        for times_at_once in np.array_split(missing_times, n_blocks):
            # The edges follow from the loads alone, before the scene is solved.
            contact_edges = _contact_edges_at(scene, times_at_once)
            order_by_length = np.argsort(contact_edges[:, 1] - contact_edges[:, 0])
            places = _places_for_tractions(contact_edges[order_by_length])
            solution = solve(scene, x=places, time=times_at_once, fields=("pressure", "shear"))
            solutions_and_rows |= {
                time: (solution, row) for row, time in enumerate(times_at_once.tolist())
            }
    return [solutions_and_rows[time] for time in times.tolist()]


def _contact_edges_at(scene: Scene, times: Array) -> Array:
    """Left and right edge of the contact at n times of the load path, (n, 2) [length]. They follow
    from P and the tilt then. A time outside the path counts as its start or end.
    """
    path_loads, profile = path_loads_and_contact(scene)
    normal_load, _, _, tilt = path_loads.loads_at(times)
    centre, half_width = profile.centre_and_half_width_under(normal_load, tilt)
    return np.stack([centre - half_width, centre + half_width], axis=-1)


def _rows_with_tractions(
    solution: ContactSolution, times: Array
) -> dict[float, tuple[ContactSolution, int]]:
    """By time: a half-plane solution and the number (row) of the instant in it, for those
    `times` at which its tractions are known well enough.

    They are if the solution has 60 points in the contact then, or if there is no contact. Times
    agree within 1e-9 of themselves. Empty where pressure or shear is NaN anywhere in the solution.
    """
    if not (np.isfinite(solution.pressure).all() and np.isfinite(solution.shear).all()):
        return {}
    nearest_rows = np.argmin(np.abs(solution.time[:, None] - times), axis=0)
    n_points_in_contact = np.sum(solution.pressure[nearest_rows] > 0, axis=1)
    has_enough_points = n_points_in_contact >= _FEWEST_PLACES_IN_CONTACT
    is_out_of_contact = solution.normal_load[nearest_rows] <= 0
    has_instant = np.abs(solution.time[nearest_rows] - times) <= 1e-9 * np.abs(times)
    time_numbers = np.flatnonzero((has_enough_points | is_out_of_contact) & has_instant)
    return {
        float(times[time_number]): (solution, int(nearest_rows[time_number]))
        for time_number in time_numbers
    }


def _places_for_tractions(contact_edges: Array) -> Array:
    """Places x, ascending [length], at which tractions are to be solved for at n instants: across
    at most four of the contacts, and close to the edges of all.

    `contact_edges` (n, 2) are the left and right edge of each contact, the shortest contact first.
    """
    # The shortest, the longest and two between; 601 places across each.
    contact_numbers = np.unique(
        np.linspace(0, len(contact_edges) - 1, _MOST_CONTACTS_WITH_PLACES).round().astype(int)
    )
    chosen_edges = contact_edges[contact_numbers]
    middle = chosen_edges.mean(axis=1)[:, None]
    half_width = np.diff(chosen_edges) / 2
    cosines = np.cos(np.linspace(0, math.pi, _PLACE_COUNT_ACROSS_CONTACT))
    places_across = middle - half_width * cosines
    # Distances from each edge: 1e-7 to 2.5e-2 of the contact's length.
    inwards = np.array([[1.0], [-1.0]])
    contact_length = np.diff(contact_edges)[:, :, None]
    places_at_edges = contact_edges[:, :, None] + contact_length * inwards * _WIDTH_SHARES_FROM_EDGE
    return np.unique(np.concatenate([places_across.ravel(), places_at_edges.ravel()]))


def _bulk_stresses(solutions_and_rows: list[tuple[ContactSolution, int]]) -> Array:
    """Bulk stress of the lower and the upper body at n instants, (n, 2) [stress], tension positive.

    `solutions_and_rows` has for each instant a solution, and the number (row) of the instant in it.
    0 where the solution has no bulk stress.
    """
    stresses = np.zeros((len(solutions_and_rows), 2))
    for instant_number, (solution, row) in enumerate(solutions_and_rows):
        if solution.bulk_stress_lower is not None:
            stresses[instant_number, 0] = solution.bulk_stress_lower[row]
        if solution.bulk_stress_upper is not None:
            stresses[instant_number, 1] = solution.bulk_stress_upper[row]
    return stresses


# q/(f p) (n, k) of a solution on grids, at its instants and points, by coarse grids: cached as long
# as the solution exists.
_coarse_ratio_by_solution: WeakKeyDictionary[ContactSolution, RatioOnGrids] = WeakKeyDictionary()


def _ratio_on_coarse_grids(
    solution: ContactSolution, path_loads: PathLoads, tilted_contact: TiltedProfile
) -> RatioOnGrids | None:
    """q/(f p) at the n instants and k points of a half-plane solution, by grids of half as many
    cells and increments, followed for as many cycles.

    None where the solution is not from grids. NaN where an increment of the coarse grids does not
    converge. The path is followed once; later calls take the cached ratio.

    Parameters
    ----------
    path_loads
        P, Q, bulk strain and tilt of the scene over time
    tilted_contact
        normal contact of its profile under load and tilt
    """
    # Of a solution on grids `work.counts` has the number of grids, and that of the cycles solved.
    counts = solution.work.counts
    if "grids" not in counts:
        return None
    if solution not in _coarse_ratio_by_solution:
        scene = solution.scene
        # Half of the usual 160 cells across the contact, and of 320 increments a cycle.
        request = GridRequest(
            most_cycles=counts["cycles_solved"],
            cells=CELLS_ACROSS_CONTACT // 2,
            increments=INCREMENTS_PER_CYCLE // 2,
        )
        try:
            coarse_ratio = friction_ratio_on_grids(
                path_loads,
                tilted_contact,
                scene.profile.height,
                scene.friction.coefficient,
                solution.x,
                solution.time,
                request,
            )
        except InputError:  # near sliding all of the coarse cells may slip
            unknown_ratio = np.full((len(solution.time), len(solution.x)), np.nan)
            coarse_ratio = RatioOnGrids(unknown_ratio, math.nan)
        _coarse_ratio_by_solution[solution] = coarse_ratio
    return _coarse_ratio_by_solution[solution]


class _TensionOfSliding(NamedTuple):
    """Tension s_xx of the lower face at both edges of one contact if all of it slipped, q = f p,
    as the mean of the contributions of nodes across the contact.
    """

    # (512,) places of the nodes, from the left edge on [length]
    x_of_nodes: Array
    # (2, 512) contribution of each node at the left and at the right edge [stress]
    by_node: Array

    def times_ratio(self, x_of_points: Array, friction_ratio: Array) -> Array:
        """Tension at the left and at the right edge (2,) under q = f p times `friction_ratio`: the
        ratio q/(f p) at points (k,), linear between them.
        """
        ratio_at_nodes = np.interp(self.x_of_nodes, x_of_points, friction_ratio)
        return np.mean(self.by_node * ratio_at_nodes, axis=1)


def _tension_of_sliding(
    solution: ContactSolution, row: int, tilted_contact: TiltedProfile
) -> _TensionOfSliding:
    """Tension s_xx of the lower face at both edges of contact if all of the contact slipped, q = f
    p, of a half-plane solution at its instant number `row`.

    The tension is (2/pi) int q/|x - edge| dx at the left edge, and minus that at the right one.
    With x = middle - half_width cos(phi) it is the mean over phi, from 0 to pi, of 2 q cot(phi/2)
    at the left edge, and of -2 q tan(phi/2) at the right one.

    `tilted_contact` is the normal contact of the profile, whose exact pressure is taken.
    """
    phi, x_of_nodes = _places_across(solution, row, _PLACES_OF_TENSION)
    pressure = _pressure_across(solution, row, tilted_contact, x_of_nodes)
    friction_limit = solution.scene.friction.coefficient * pressure
    by_node = 2 * friction_limit * np.stack([1 / np.tan(phi / 2), -np.tan(phi / 2)])
    return _TensionOfSliding(x_of_nodes, by_node)


def _edge_tensions_of_solution(
    solution: ContactSolution,
    row: int,
    tilted_contact: TiltedProfile,
    coarse_grids: RatioOnGrids | None = None,
) -> tuple[Array, Array]:
    """Stress s_xx of the lower face at the left and the right edge of contact, by the tractions of
    a half-plane solution, and its uncertainty: (2,) each [stress]; without the bulk stress.

    The stress is (2/pi) int q/|x - edge| dx at the left edge, and minus that at the right one.
    Tension is positive. q is the exact f p times q/(f p), which is taken as linear between the
    points of the solution.

    The uncertainty is the root of the sum of the squares of

    - the error of the lines between the points;
    - the tension of a slip zone too narrow for the points and cells;
    - of a solution on grids, the change by coarse grids, and a share of the error of its shear;
    - of any other solution, 1e-3 of f times the largest pressure.

    Stress and uncertainty are 0 where no point is in contact.

    Parameters
    ----------
    solution, row
        the solution, and the number of its instant
    tilted_contact
        normal contact of the profile, whose exact pressure is taken
    coarse_grids
        of a solution on grids: q/(f p) at its instants and points by cells twice as wide, and
        their width; NaN where these grids did not converge
    """
    is_in_contact = solution.pressure[row] > 0
    if not is_in_contact.any():
        return np.zeros(2), np.zeros(2)
    friction_coefficient = solution.scene.friction.coefficient
    x_of_points = solution.x[is_in_contact]
    friction_limit = friction_coefficient * solution.pressure[row, is_in_contact]
    friction_ratio = solution.shear[row, is_in_contact] / friction_limit
    sliding_tension = _tension_of_sliding(solution, row, tilted_contact)
    tensions = sliding_tension.times_ratio(x_of_points, friction_ratio)
    error_between_points = _tension_error_between_points(
        sliding_tension, x_of_points, friction_ratio, tensions
    )

    # f p at its largest
    largest_friction_limit = friction_coefficient * float(solution.pressure[row].max())
    if coarse_grids is None:
        cell_width = 0.0
        change_by_grids = np.zeros(2)
        # 1e-3 of the largest f p
        error_by_shear = _TENSION_ERROR_SHARE_BETWEEN_PLACES * largest_friction_limit
    else:
        # cells of the solution itself
        cell_width = coarse_grids.cell_width / 2
        coarse_ratio = coarse_grids.friction_ratio[row, is_in_contact]
        change_by_grids = sliding_tension.times_ratio(x_of_points, coarse_ratio) - tensions
        # stated error of the shear, over the largest shear
        shear_error_share = solution.record.errors.get("shear", 0.0)
        error_by_shear = (
            _TENSION_ERROR_OVER_SHEAR_ERROR * shear_error_share * largest_friction_limit
        )

    # at the left edge and at the right one
    slip_zone_tensions = np.array(
        [
            _tension_of_narrow_slip_zone(
                np.abs(x_of_points - contact_edge),
                friction_ratio,
                cell_width,
                np.abs(sliding_tension.x_of_nodes - contact_edge),
                np.abs(sliding_tension.by_node[edge_number]),
            )
            for edge_number, contact_edge in enumerate(solution.contact_edges[row].tolist())
        ]
    )
    uncertainty = np.sqrt(
        error_between_points**2 + change_by_grids**2 + error_by_shear**2 + slip_zone_tensions**2
    )
    return tensions, uncertainty


def _tension_error_between_points(
    sliding_tension: _TensionOfSliding,
    x_of_points: Array,
    friction_ratio: Array,
    tensions: Array,
) -> Array:
    """Error of the tension at the left and the right edge of contact (2,) [stress], as q/(f p) is
    taken as linear between points.

    Straight lines err by the square of the distance of the points. So the error is a third of the
    change if every second point is omitted. The larger change counts of omitting the points of odd
    and those of even number.

    Parameters
    ----------
    sliding_tension
        tension if all of the contact slipped; `times_ratio` gives that under q/(f p)
    x_of_points, friction_ratio
        (k,) places of the points in contact [length], and q/(f p) there
    tensions
        (2,) tension under the q/(f p) of all points [stress]
    """
    changes = [
        np.abs(
            sliding_tension.times_ratio(x_of_points[every_second], friction_ratio[every_second])
            - tensions
        )
        for every_second in (slice(0, None, 2), slice(1, None, 2))
        if len(x_of_points[every_second])
    ]
    return _ERROR_OVER_CHANGE_BY_POINTS * np.max(changes, axis=0)


def _tension_of_narrow_slip_zone(
    point_distances: Array,
    friction_ratio: Array,
    cell_width: float,
    node_distances: Array,
    sliding_tension_of_nodes: Array,
) -> float:
    """Estimate of the tension at an edge of contact [stress] by a slip zone that has just begun
    there, and is too narrow for the cells and points of a solution.

    Beside an edge p = K sqrt(d) at the distance d. Where a load has turned, a slip zone of width z
    changes q by -F (sqrt(d) - sqrt(d - z)), with F = f K |s - r|. Here r is q/(f p) before, and s =
    +-1 its value in slip. Farther in that is F z/(2 sqrt(d)); of the tension it is 2 F sqrt(z).

    The solution holds only the change of q farther in, which grows as z. So the tension grows as
    the root of two factors:

    - the size of the difference of q/(f p) between the edge and one cell farther in;
    - |s - r|, where s is the sign of that difference.

    It is 0 where the cell beside the edge slips that way already: the zone is wider than the cell.

    Parameters
    ----------
    point_distances, friction_ratio
        (k,) distances of points in contact from the edge [length], and q/(f p) there
    cell_width
        of the grids; 0 without grids [length]
    node_distances, sliding_tension_of_nodes
        (m,) distances of quadrature nodes across the contact from the edge [length], and the
        contribution of each to the tension by q = f p, which is their mean [stress]
    """
    order_from_edge = np.argsort(point_distances)
    # The solution resolves nothing nearer to the edge than its nearest point, or within a cell.
    unresolved_width = cell_width + float(point_distances[order_from_edge[0]])
    ratio_at_edge, ratio_farther_in = np.interp(
        [0.0, unresolved_width], point_distances[order_from_edge], friction_ratio[order_from_edge]
    )
    ratio_difference = float(ratio_at_edge - ratio_farther_in)
    # |s - r|, of which r is q/(f p) at the edge
    ratio_left_to_slip = 1 - math.copysign(1.0, ratio_difference) * float(ratio_at_edge)
    # tension by q = f p in the unresolved width alone
    sliding_tension_of_width = float(
        np.mean(sliding_tension_of_nodes * (node_distances < unresolved_width))
    )
    share_of_sliding_tension = math.sqrt(abs(ratio_difference) * max(ratio_left_to_slip, 0.0) / 2)
    return _TENSION_OF_NARROW_SLIP_ZONE * sliding_tension_of_width * share_of_sliding_tension


def _places_across(solution: ContactSolution, row: int, n_places: int) -> tuple[Array, Array]:
    """Angles phi between 0 and pi, and places middle - half_width cos(phi) [length] across the
    contact of a solution at the instant number `row`, (n_places,) each, from the left edge on.
    """
    left_edge, right_edge = solution.contact_edges[row]
    phi = math.pi * (np.arange(n_places) + 0.5) / n_places
    return phi, (left_edge + right_edge) / 2 - (right_edge - left_edge) / 2 * np.cos(phi)


def _pressure_across(
    solution: ContactSolution, row: int, tilted_contact: TiltedProfile, places: Array
) -> Array:
    """Exact pressure at places x (n,) in the contact of a solution at the instant number `row`,
    (n,) [stress], from the middle and the half-width of the contact. `tilted_contact` is the normal
    contact of the profile under load and tilt.
    """
    contact_edges = solution.contact_edges[row]
    middle = contact_edges.mean(keepdims=True)
    half_width = np.diff(contact_edges) / 2
    return tilted_contact.pressure_over(places, middle, half_width)[0]


def _stress_by_sine_series(
    solution: ContactSolution,
    row: int,
    tilted_contact: TiltedProfile,
    x: Array,
    y: Array,
    sign_of_body: float,
) -> Array:
    """Stress s_xx, s_yy, s_xy of a body below y = 0 at n points x, y, (n, 3) [stress], by sine
    series of the tractions of a half-plane solution at one instant; without the bulk stress.

    A traction sum A_k sin(k phi) on the face, with x = middle + half_width cos(phi), has
    Muskhelishvili's potential pi sum A_k omega^k. Here omega = zeta - sqrt(zeta^2 - 1), and zeta =
    (x + i y - middle)/half_width. The stress follows from N, the potential of the pressure, and T,
    that of the shear. It is 0 where no point of the solution is in contact.

    Parameters
    ----------
    solution, row
        the solution, and the number of its instant
    tilted_contact
        normal contact of the profile, whose exact pressure is taken
    x, y
        (n,) coordinates of the points [length], y <= 0
    sign_of_body
        1 for the lower body, -1 for the mirror image of the upper one, on which the shear acts the
        other way
    """
    if not np.any(solution.pressure[row] > 0):
        return np.zeros((len(x), 3))
    left_edge, right_edge = solution.contact_edges[row]
    middle = (left_edge + right_edge) / 2
    half_width = (right_edge - left_edge) / 2
    sine_coefficients = _sine_coefficients_of_tractions(solution, row, tilted_contact)
    sine_coefficients[1] *= sign_of_body

    # The sums are taken at the mirror image x - i y, above the branch cut of the root. The
    # coefficients are real, so that the sum at x + i y is the conjugate.
    zeta = (x - middle + 0j) / half_width
    zeta.imag = np.abs(y) / half_width
    root_of_zeta = np.sqrt(zeta - 1) * np.sqrt(zeta + 1)
    omega = zeta - root_of_zeta
    power_sums, weighted_power_sums = _power_sums(sine_coefficients, omega)
    potentials = math.pi * power_sums.conj()
    with np.errstate(divide="ignore", invalid="ignore"):
        # y dN/dz and y dT/dz by d omega/dz = -omega/(half_width root_of_zeta)
        y_derivatives = math.pi * np.where(
            y == 0, 0.0, -y * (weighted_power_sums / (half_width * root_of_zeta)).conj()
        )
    return _stress_from_potentials(*potentials, *y_derivatives)


def _sine_coefficients_of_tractions(
    solution: ContactSolution, row: int, tilted_contact: TiltedProfile
) -> Array:
    """Coefficients A_k of p = sum A_k sin(k phi) and of q, (2, 2048) from k = 1 on [stress], across
    the contact of a half-plane solution at its instant number `row`.

    phi is the angle from the right edge of contact: x = middle + half_width cos(phi). p is the
    exact pressure by `tilted_contact`, the normal contact of the profile. q is p times q/p, which
    is linear between the points of the solution.
    """
    is_in_contact = solution.pressure[row] > 0
    # As many places as terms, from the left edge on.
    _, places = _places_across(solution, row, _SERIES_TERMS)
    pressure = _pressure_across(solution, row, tilted_contact, places)
    ratio_at_points = solution.shear[row, is_in_contact] / solution.pressure[row, is_in_contact]
    shear = pressure * np.interp(places, solution.x[is_in_contact], ratio_at_points)
    tractions_from_right_edge = np.stack([pressure, shear])[:, ::-1]
    return scipy.fft.dst(tractions_from_right_edge, 2) / _SERIES_TERMS


def _power_sums(coefficients: Array, omega: Complex) -> tuple[Complex, Complex]:
    """Sums of A_k omega^k and of k A_k omega^k over k = 1 to m, (2, n) each, of two sets of
    coefficients A_k, (2, m), at n complex numbers |omega| <= 1.

    Horner's rule runs from the last term to the first. At each omega it starts where |omega|^k is
    above 1e-17.
    """
    n_terms = coefficients.shape[1]
    with np.errstate(divide="ignore"):
        log_of_omega = np.log(np.minimum(np.abs(omega), 1 - 1e-12))
        terms_needed = np.minimum(np.ceil(math.log(_NEGLIGIBLE_POWER) / log_of_omega), n_terms)
    # Numbers with most terms come first: those with a term k are the first n_with_term[k - 1].
    order_by_terms = np.argsort(-terms_needed, kind="stable")
    omega = omega[order_by_terms]
    n_with_term = np.searchsorted(
        -terms_needed[order_by_terms], -np.arange(1, n_terms + 1), side="right"
    )
    # Two sums of A_k omega^k, then two of k A_k omega^k.
    sums = np.zeros((4, len(omega)), dtype=complex)
    for k in range(n_terms, 0, -1):
        n_numbers = n_with_term[k - 1]
        coefficient = coefficients[:, k - 1, None]
        sums[:2, :n_numbers] = (sums[:2, :n_numbers] + coefficient) * omega[:n_numbers]
        sums[2:, :n_numbers] = (sums[2:, :n_numbers] + k * coefficient) * omega[:n_numbers]
    sums[:, order_by_terms] = sums.copy()
    return sums[:2], sums[2:]


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
    normal_load = float(snapshot.load[instant_number])
    stick_edge_load = float(snapshot.load[instant_number] - snapshot.slip_zone_load[instant_number])
    if stick_edge_load < normal_load:
        slip_zone_slope = float(snapshot.direction[instant_number] * snapshot.friction)
        yield (
            max(stick_edge_load, 0.0),
            normal_load,
            lambda eta: np.full(eta.shape, slip_zone_slope),
        )
    piece_at_edge = snapshot.sticking_pieces[snapshot.piece_number[instant_number]]
    # The pieces that are linked to it, from the one with the largest loads down.
    for piece in pieces(piece_at_edge):
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
    """Muskhelishvili's potentials N of pressure and T of shear, and their derivatives, at n points
    x + i y, y <= 0: complex (4, n), summed over the flat punches of a contact.

    The memory curve M(eta) is the tangential force of the punches up to the normal load eta. The
    derivatives stay 0 on the face, where they only occur times y.

    Parameters
    ----------
    contact
        normal contact of the profile, with half-widths a(P)
    curve_parts
        lower load, upper load and slope M' of each smooth part of M; M' is the tangential load of a
        punch per normal load
    x, y
        (n,) coordinates of the points [length]
    """
    potentials = np.zeros((4, len(x)), dtype=complex)
    distance_from_middle = np.abs(x)
    for lower_load, upper_load, slope in curve_parts:
        least_half_width = float(contact.half_width(lower_load))
        largest_half_width = float(contact.half_width(upper_load))
        for panel_ends in _panels_between(contact, least_half_width, largest_half_width):
            _add_panel_of_punches(potentials, contact, slope, panel_ends, distance_from_middle, y)
    # To the left of the middle the potentials and derivatives follow by symmetry.
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
    """Signed distances from `place` to the quadrature nodes between `begin` and `end`, without
    cancellation at either end; a new last axis is that of the nodes.

    The nodes are crowded at both ends, for integrands with inverse roots there. The arrays
    broadcast.
    """
    # Distances of its nodes from the begin and from the end of a range of length 1.
    rule = RULE_FOR_INVERSE_ROOTS
    range_length = np.subtract(end, begin)
    distance_by_begin = np.subtract(begin, place) + range_length * rule.distance_from_begin
    distance_by_end = np.subtract(end, place) - range_length * rule.distance_from_end
    return np.where(rule.distance_from_begin < 0.5, distance_by_begin, distance_by_end)


def _add_panel_of_punches(
    potentials: Complex,
    contact: SymmetricContact,
    slope: Slope,
    panel_ends: tuple[float, float],
    x: Array,
    y: Array,
) -> None:
    """Add to Muskhelishvili's potentials at n points x >= 0, y <= 0 the flat punches of one panel,
    a range of half-widths.

    The potential of a punch is singular on the face where x is its half-width. So the quadrature
    over the half-widths is cut at x for a point with x inside the panel.

    Parameters
    ----------
    potentials
        complex (4, n): N of pressure, T of shear and their derivatives
    contact
        normal contact of the profile: the load eta of a half-width
    slope
        tangential load of a punch per normal load, M', as a function of eta
    panel_ends
        least and largest half-width [length]
    x, y
        (n,) coordinates of the points [length]
    """
    least_half_width, largest_half_width = panel_ends
    rule = RULE_FOR_INVERSE_ROOTS
    half_widths = _distances_to_nodes(0.0, least_half_width, largest_half_width)
    panel_width = largest_half_width - least_half_width
    # Normal and tangential load of the punches at the nodes, (2, nodes).
    punch_loads = _loads_of_punches(contact, slope, half_widths, panel_width * rule.weight)
    # A million pairs of point and node at once bound the memory.
    points_at_once = _KERNELS_AT_ONCE // len(rule.weight)

    is_in_panel = (x > least_half_width) & (x < largest_half_width)
    points_beside = np.flatnonzero(~is_in_panel)
    for point_numbers in np.array_split(points_beside, 1 + len(points_beside) // points_at_once):
        distance_to_punch = _distances_to_nodes(
            x[point_numbers, None], least_half_width, largest_half_width
        )
        _add_punches(potentials, point_numbers, punch_loads, distance_to_punch, x, y)

    points_in_panel = np.flatnonzero(is_in_panel)
    for point_numbers in np.array_split(
        points_in_panel, 1 + len(points_in_panel) // points_at_once
    ):
        for panel_end in panel_ends:
            _add_punches_up_to_end(potentials, contact, slope, panel_end, point_numbers, x, y)


def _add_punches_up_to_end(
    potentials: Complex,
    contact: SymmetricContact,
    slope: Slope,
    panel_end: float,
    point_numbers: Indices,
    x: Array,
    y: Array,
) -> None:
    """Add to Muskhelishvili's potentials at some points x >= 0, y <= 0 the flat punches of
    half-widths between x itself and `panel_end`, narrower or wider ones [length].

    Parameters
    ----------
    potentials
        complex (4, n): N of pressure, T of shear and their derivatives at all points
    contact
        normal contact of the profile: the load eta of a half-width
    slope
        tangential load of a punch per normal load, M', as a function of eta
    point_numbers
        (m,) numbers of the points
    x, y
        (n,) coordinates of all points [length]
    """
    # Distances of its nodes from the begin and from the end of a range of length 1, and weights.
    rule = RULE_FOR_INVERSE_ROOTS
    x_of_points = x[point_numbers, None]
    sign = np.where(panel_end > x_of_points, 1.0, -1.0)
    range_width = sign * (panel_end - x_of_points)
    distance_to_punch = sign * range_width * rule.distance_from_begin
    # Without cancellation: each node from the end of the range that is nearer to it.
    half_widths = np.where(
        rule.distance_from_begin < 0.5,
        x_of_points + distance_to_punch,
        panel_end - sign * range_width * rule.distance_from_end,
    )
    punch_loads = _loads_of_punches(contact, slope, half_widths, range_width * rule.weight)
    _add_punches(potentials, point_numbers, punch_loads, distance_to_punch, x, y)


def _loads_of_punches(
    contact: SymmetricContact, slope: Slope, half_widths: Array, node_weights: Array
) -> Array:
    """Normal load d eta and tangential load M' d eta of the flat punches at quadrature nodes,
    (2, ...) [force per thickness].

    Parameters
    ----------
    contact
        normal contact of the profile: the load eta of a half-width, and d eta/da (`stiffness`)
    slope
        tangential load of a punch per normal load, M', as a function of eta
    half_widths, node_weights
        (...) half-widths a of the punches, and weights d a of the nodes [length]
    """
    normal_loads = contact.stiffness(half_widths) * node_weights
    return np.stack([normal_loads, normal_loads * slope(contact.load(half_widths))])


def _add_punches(
    potentials: Complex,
    point_numbers: NDArray[np.intp],
    punch_loads: Array,
    distance_to_punch: Array,
    x: Array,
    y: Array,
) -> None:
    """Add to Muskhelishvili's potentials at some points those of flat punches, 1/sqrt(z^2 - a^2)
    times the load of a punch of half-width a, z = x + i y.

    Parameters
    ----------
    potentials
        complex (4, n): N of pressure (normal loads), T of shear (tangential loads), dN/dz, dT/dz at
        all points. The derivatives are left 0 on the face y = 0
    point_numbers
        (m,) numbers of the points
    punch_loads
        normal and tangential load of each punch, (2, punches) alike for all points, or (2, m,
        punches)
    distance_to_punch
        (m, punches) a - x [length], of which z^2 - a^2 is formed without cancellation
    x, y
        (n,) coordinates of all points [length]
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
    inverse_root = 1 / np.sqrt(difference_of_squares)
    potentials[:2, point_numbers] += np.einsum(
        "...mn,mn->...m" if punch_loads.ndim == 3 else "kn,mn->km", punch_loads, inverse_root
    )
    # Derivatives -z/(z^2 - a^2)^(3/2), of the points inside the body.
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
