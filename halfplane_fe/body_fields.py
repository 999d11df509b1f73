"""Displacement and stress in both bodies at chosen instants, from the stored interface states.

Stress is that of the elements, averaged at the nodes; next to the contact that of the tractions,
see `face_stress`. Both have the bulk stress in them: uniform in half-planes, that of the elements
in blocks.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
import scipy
import skfem
from numpy.typing import ArrayLike
from skfem.helpers import sym_grad

from halfplane_fe.elasticity import (
    CondensedBody,
    cells_of,
    displacement_by_unit_stress,
    displacement_fields,
    scalar_element,
    split_lame,
)
from halfplane_fe.face_stress import (
    FEWEST_NODES,
    N_DISTORTED_NODES,
    NodalTractions,
    SizeEffect,
    Tractions,
    edge_tension_by_nodal_shear,
    fitted_size_effect,
    sampled_tractions,
    tractions,
    tractions_with_uncertainty,
)
from halfplane_fe.interface import body_forces
from halfplane_fe.kernel_bodies import BodyKernels, body_kernels
from halfplane_fe.path import has_bulk_stress
from halfplane_fe.remainder import nearest_end, require_known_effects
from halfplane_fe.scales import contact_modulus
from halfplane_fe.solution import FiniteElementSolution, KernelSolution
from halfplane_fe.supports import bodies_are_alike
from scenes import ContactSolution, Elastic, HalfPlane, InputError, Scene, Tabulated
from scenes.array_types import Array, Indices
from scenes.bodies import Block, Shape, TShape, face_of
from scenes.solution import require_solution

# VTK's order of an element's nodes the other way round, by number of nodes.
_NODES_OF_MIRRORED = {
    3: [0, 2, 1],
    6: [0, 2, 1, 5, 4, 3],
    4: [0, 3, 2, 1],
    9: [0, 3, 2, 1, 7, 6, 5, 4, 8],
}

_BODY_NAMES = ("lower", "upper")
# Distance from the middle of the contact over its half-width up to which the stress at nodes is
# that of the tractions,
_OUTER_DISTANCE = 3.0
# but no further than this share of the way to the nearest support or side;
_SHARE_OF_DISTANCE_TO_SUPPORT = 0.8
# over the last share of it the elements' takes its place.
_BLENDING_SHARE = 0.2
# A body has room for the tractions' stress only if that distance over the half-width is larger.
_LEAST_OUTER_DISTANCE = 1.5
# Least distance of its sides and supports for that, over the half-width.
_LEAST_ROOM = _LEAST_OUTER_DISTANCE / _SHARE_OF_DISTANCE_TO_SUPPORT
# Depth and distance over the half-width from which on elements are good for what the size of the
# body adds.
_ACCURATE_DEPTH = 0.15
_ACCURATE_DISTANCE = 1.2
# Pressure of a node over the largest one up to which it is round-off.
_NEGLIGIBLE_PRESSURE = 1e-9
# Step over the place of a kink of the profile by which its curvature on either side is found.
_STEP_AT_KINK = 1e-3
# Instants of a cycle at which the elements give the stress that the size of a body adds.
_N_SAMPLED_STEPS = 12
# The same where the instants of the largest tension are looked for. Of an ellipse a spline through
# six is 2 % of the amplitude off.
_N_SAMPLED_STEPS_OF_SEARCH = 6
# Instants of a cycle among which the largest tension is looked for.
_N_CANDIDATE_STEPS = 40
# Of a tension: two ways to sum one series differ by less.
_ROUND_OFF = 1e-9
# Tension by fitted edges over that by nodal values, at most: 0.9 to 1.13 on coarse meshes of the
# library's scenes.
_LARGEST_RATIO_TO_NODAL = 1.3
# Share of what new contact may change that it does change where one of its nodes shows the shear:
# 0.15 at most on seed 250 of benchmarks/covered.py values, default preset.
_SHARE_SHOWN_BY_A_NODE = 0.25
# Angles over the contact at which tractions meet the kernels of a body, which are smooth.
_N_ANGLES = 128
# How far an instant may lie outside the solved time by rounding.
_ROUNDING_OF_TIME = 1e-9


@dataclass(frozen=True, eq=False)
class BodyFields:
    """Nodal fields of one body at one instant, in the common frame (x along the surface, y out of
    the lower body).

    Attributes
    ----------
    name
        "lower" or "upper"
    points
        (n, 2) undeformed places [length]
    cells
        (n_elements, 3, 6, 4 or 9): corners counter-clockwise, mid-side nodes, middle
    displacement
        (n, 2) [length]; that of the upper body includes its tangential displacement and
        approach
    stress
        (n, 4) xx, yy, xy, zz [stress]: beside the contact that of the tractions, further away
        carried to each node from its elements and averaged there
    von_mises
        (n,) [stress]
    edges
        (2,) x of the left and right edge of contact, by the tractions [length]; NaN where fewer
        than three nodes touch
    edge_tension, edge_tension_uncertainty
        (2,) xx of the face at those edges, which lie between nodes [stress]; NaN in a body so
        thin that what its size adds is not known
    """

    name: str
    points: Array
    cells: Indices
    displacement: Array
    stress: Array
    von_mises: Array
    edges: Array
    edge_tension: Array
    edge_tension_uncertainty: Array


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Loads, and the fields of both bodies, at one instant."""

    time: float
    normal_load: float
    tangential_load: float
    bodies: tuple[BodyFields, BodyFields]


def fields(solution: FiniteElementSolution, instants: Iterable[float]) -> tuple[Snapshot, ...]:
    """Stress and displacement at the nodes of both bodies, at given instants of a finite-element
    solution.

    Parameters
    ----------
    solution
        by finite elements, solved in this process: only then its meshes are there
    instants
        times; the stored step nearest to each is taken

    Returns
    -------
    tuple of Snapshot
        For each instant the loads and the fields of the lower and the upper body.

    Raises
    ------
    InputError
        For an instant outside the solved time; for a solution without meshes.
    """
    _require_meshes("fields", solution)
    # indices of the stored instants
    steps = [_nearest_step("fields", solution, float(instant)) for instant in instants]
    if not steps:
        return ()
    fields_of_lower_body, fields_of_upper_body = _fields_of_bodies(solution, steps)
    return tuple(
        Snapshot(
            time=float(solution.time[step]),
            normal_load=float(solution.normal_load[step]),
            tangential_load=float(solution.tangential_load[step]),
            bodies=(lower_fields, upper_fields),
        )
        for step, lower_fields, upper_fields in zip(
            steps, fields_of_lower_body, fields_of_upper_body, strict=True
        )
    )


def _require_meshes(caller: str, solution: ContactSolution) -> None:
    """Raise InputError for a solution without meshes: one that is not by finite elements, or that
    was read back from disk. `caller` is the name of the public function for the message.
    """
    require_solution(solution, caller)
    if not isinstance(solution, FiniteElementSolution):
        raise InputError(
            f"{caller}: the answer has no meshes, so nothing inside the bodies is known"
        )


def _fields_of_bodies(
    solution: FiniteElementSolution, steps: Sequence[int]
) -> list[list[BodyFields]]:
    """Nodal stress and displacement of the lower and of the upper body of a solution, in the common
    frame (y out of the lower body). Each body has a list of `BodyFields`, one for each step.

    Parameters
    ----------
    solution
        by finite elements: its `condensed_bodies` (lower, upper) hold mesh, material and order of
        the elements
    steps
        indices of stored instants
    """
    # s_xx at both edges of contact, (n_steps, 2, 2) by body and edge
    tension, tension_uncertainty = edge_tension(solution, steps)
    # p and q on the lower body as sine series; None where fewer than three nodes touch
    tractions_at_steps = _tractions_at_steps(solution, steps)
    contact_edges = [
        (np.nan, np.nan) if step_tractions is None else step_tractions.edges
        for step_tractions in tractions_at_steps
    ]
    fields_of_bodies = []
    # _BODY_NAMES: "lower", "upper"
    for body_number, name in enumerate(_BODY_NAMES):
        displacement, stress = _displacement_and_stress(
            solution, steps, tractions_at_steps, body_number
        )
        points, cells = _nodes_and_elements(solution.condensed_bodies[body_number], body_number)
        fields_of_steps = [
            BodyFields(
                name=name,
                points=points,
                cells=cells,
                displacement=displacement[k] + _rigid_motion(solution, body_number, step, points),
                stress=stress[k],
                von_mises=_von_mises(stress[k]),
                edges=np.array(contact_edges[k]),
                edge_tension=tension[k, body_number],
                edge_tension_uncertainty=tension_uncertainty[k, body_number],
            )
            for k, step in enumerate(steps)
        ]
        fields_of_bodies.append(fields_of_steps)
    return fields_of_bodies


def _nodes_and_elements(condensed_body: CondensedBody, body_number: int) -> tuple[Array, Indices]:
    """Places (n, 2) of the nodes of the lower (0) or upper (1) body in the common frame, with y out
    of the lower body [length], and the node numbers of its elements, counter-clockwise.
    """
    mesh = condensed_body.body.mesh  # with y out of its own body
    points = mesh.p.T * [1.0, _sign_of_y(body_number)]
    return points, _counter_clockwise_cells(points, cells_of(mesh, condensed_body.order))


def _sign_of_y(body_number: int) -> float:
    """Factor from a body's own y (out of the body) to the common y (out of the lower body): 1 of
    the lower body (0), -1 of the upper one (1).
    """
    return 1.0 - 2.0 * body_number


def _displacement_and_stress(
    solution: FiniteElementSolution,
    steps: Sequence[int],
    tractions_at_steps: Sequence[Tractions | None],
    body_number: int,
) -> tuple[Array, Array]:
    """Displacement (n_steps, n, 2) [length] and stress xx, yy, xy, zz (n_steps, n, 4) [stress] at
    the n nodes of one body. The frame is the common one (y out of the lower body).

    Far from the contact the stress is that of the elements. Next to it, it is that of the tractions
    on a half-plane plus what the finite size of the body adds; that of the elements again where a
    support or side is too near. Both results contain the bulk stress. The rigid motion of the upper
    body is left out.

    Parameters
    ----------
    solution
        by finite elements: used are its bodies, condensed bodies and interface states
    steps
        indices of stored instants
    tractions_at_steps
        tractions on the lower body at each step, as sine series; None where fewer than three nodes
        touch
    body_number
        0 of the lower body, 1 of the upper one
    """
    material = solution.condensed_bodies[body_number].material
    sign_of_y = _sign_of_y(body_number)  # -1 of the upper body, whose own y points down
    bulk_stress = _bulk_stress(solution, steps, body_number)  # (n_steps,)

    # Stress by the elements at all nodes, and that of the tractions at nodes near the contact.
    nodal_fields = _nodal_fields(solution, body_number, steps, bulk_stress)
    region_near_contact = _near_contact(solution, body_number, nodal_fields, tractions_at_steps)
    stress = (  # (n, 4, n_steps)
        nodal_fields.stress
        if region_near_contact is None
        else _joined_stress(nodal_fields, region_near_contact, material)
    )
    places = nodal_fields.basis.mesh.p  # (2, n)
    # from (2 n, n_steps), u_x and u_y of each node in turn, to (2, n, n_steps)
    displacement = nodal_fields.displacement.reshape(places.shape[1], 2, -1).swapaxes(0, 1)

    # Bulk stress of a half-plane is added; in other bodies the elements have it in them.
    # _BODY_NAMES: "lower", "upper"
    if isinstance(getattr(solution.scene.bodies, _BODY_NAMES[body_number]), HalfPlane):
        displacement = (
            displacement + displacement_by_unit_stress(material, *places)[..., None] * bulk_stress
        )
        stress_per_bulk_stress = np.array([1.0, 0.0, 0.0, material.poisson_ratio])
        stress = stress + stress_per_bulk_stress[:, None] * bulk_stress
    return (
        displacement.transpose(2, 1, 0) * [1.0, sign_of_y],
        stress.transpose(2, 0, 1) * [1.0, 1.0, sign_of_y, 1.0],
    )


def _rigid_motion(
    solution: FiniteElementSolution, body_number: int, step: int, points: Array
) -> Array:
    """Displacement (n, 2) of n points of a body as it moves rigidly at a stored step [length]: of
    the upper body by tilt, tangential displacement and normal approach; 0 of the lower one.

    Parameters
    ----------
    solution
        its `tilt` (anticlockwise; None without tilt), `tangential_displacement` along x, and
        `normal_approach`, positive downwards, are those of the upper body at each step
    body_number
        0 of the lower body, 1 of the upper one
    step
        index of a stored instant
    points
        (n, 2) places x, y in the common frame [length]
    """
    if body_number == 0:
        return np.zeros_like(points)
    tilt = 0.0 if solution.tilt is None else solution.tilt[step]
    translation = [solution.tangential_displacement[step], -solution.normal_approach[step]]
    return np.asarray(tilt * points[:, ::-1] * [-1.0, 1.0] + translation)


def _nearest_step(caller: str, solution: FiniteElementSolution, instant: float) -> int:
    """Index of the stored step of a solution whose time is nearest to an instant; InputError, which
    names the `caller`, for an instant outside the solved time.
    """
    start = float(solution.time[0])
    end = float(solution.time[-1])
    # _ROUNDING_OF_TIME: 1e-9
    if not start - _ROUNDING_OF_TIME <= instant <= end + _ROUNDING_OF_TIME:
        raise InputError(
            f"{caller}: instant {instant:.6g} lies outside the solved time, {start:.6g} to"
            f" {end:.6g}"
        )
    return int(np.argmin(np.abs(solution.time - instant)))


def edge_tension(solution: ContactSolution, steps: Sequence[int]) -> tuple[Array, Array]:
    """Stress s_xx along both faces at the edges of contact, tension positive, and its uncertainty
    [stress].

    Predictions of fretting-fatigue life use its largest value in a cycle, at the trailing edge.

    Parameters
    ----------
    solution
        by finite elements or by kernels
    steps
        (n_steps,) indices of its stored instants

    Returns
    -------
    values, uncertainties
        (n_steps, 2, 2) by body (lower, upper) and edge (left, right); 0 where P = 0; NaN where
        fewer than three nodes touch under a load, and in a body of which it is not known what its
        size adds: one with a support or side near the contact that has a curved face, bulk stress,
        or free sides on rollers, or is too thin for its kernels

    Raises
    ------
    InputError
        For bodies of finite size whose meshes are not there: answers that were read back from disk
        have none, nor have kernel solves, of which flat bodies need none.
    """
    require_solution(solution, "edge_tension")
    if not _has_data_of_size_effect(solution):
        raise InputError(
            "edge_tension: the answer has no meshes, so what the size of its bodies adds is not"
            " known; solve it again, with meshed bodies"
        )
    # its values, uncertainties, and possible change by slip zones narrower than the node spacing
    tension_record = _edge_tension(solution, steps)
    # A narrow strip of new contact, or of slip, may lie between the nodes at an edge. (n_steps, 2)
    change_by_new_contact = np.array(
        [_tension_change_by_new_contact(solution, step) for step in steps]
    )
    uncertainties = tension_record.uncertainties + change_by_new_contact.reshape(-1, 1, 2)
    return tension_record.values, np.maximum(
        uncertainties, tension_record.tension_change_by_unseen_slip
    )


def _has_data_of_size_effect(solution: ContactSolution) -> bool:
    """Whether a solution carries what the stress by the finite size of its bodies is computed from:
    their meshes, or the kernels of flat faces. Half-planes need neither.
    """
    bodies = solution.scene.bodies
    if isinstance(solution, KernelSolution):
        return not bodies.faces_are_true
    return bodies.half_planes or isinstance(solution, FiniteElementSolution)


def _tension_change_by_new_contact(solution: ContactSolution, step: int) -> Array:
    """Possible error of the tension s_xx at the left and right edge of contact, (2,) [stress],
    because the contact has grown by a strip so narrow that no node shows the shear there.

    While P grows in full stick, q/p in the new strip is dQ/dP; behind it q/p is what earlier slip
    has left. With p = K sqrt(d) near the edge of contact, a jump c of q/p at the distance w changes
    s_xx by (4/pi) c K sqrt(w). Strips are those since each earlier instant; the largest change
    counts. Of a strip that reaches the outermost node a quarter counts, beyond the rim node
    nothing. Zero where not all of the contact sticks, where P does not grow, and where too few
    nodes touch.

    # notation: d distance from the edge of contact, K constant of the pressure there, w width of
    # the strip; the rim node is the first one whose tractions the mesh leaves undisturbed, next to
    # the three outermost ones on either side

    Parameters
    ----------
    solution
        its loads P and Q, edges of stick and contact, and nodal tractions at all stored instants
    step
        index of a stored instant
    """
    if not step or not _sticks_in_full(solution, step):
        return np.zeros(2)

    # `first_step`: from it on P has grown in full stick, up to `step`
    first_step = _start_of_growth_in_stick(solution, step)
    nodal_tractions = _nodal_tractions(solution, step)  # of the nodes that touch
    # N_DISTORTED_NODES: three nodes at each edge of contact, which the mesh distorts
    if first_step == step or len(nodal_tractions.x) <= 2 * N_DISTORTED_NODES:
        return np.zeros(2)

    # Pressure at the rim node of the left and of the right side, from which K follows.
    rim_nodes = [N_DISTORTED_NODES, -1 - N_DISTORTED_NODES]
    rim_pressure = nodal_tractions.pressure[rim_nodes]
    distances_of_rim = np.abs(nodal_tractions.x[rim_nodes] - solution.contact_edges[step])

    # Jumps of q/p at the inner end of the strip since each instant, and widths of the strips.
    jump_of_ratio = _jumps_of_shear_ratio(
        solution, first_step, step, nodal_tractions.shear[rim_nodes] / rim_pressure
    )
    strip_widths = np.abs(solution.contact_edges[step] - solution.contact_edges[first_step:step])

    # Change of s_xx by each strip, (n_increments, 2): (4/pi) c K sqrt(w).
    pressure_at_width = rim_pressure * np.sqrt(strip_widths / distances_of_rim)
    distances_of_outermost = np.abs(nodal_tractions.x[[0, -1]] - solution.contact_edges[step])
    # 1 while no node lies in the strip, a quarter up to the rim node, 0 beyond it
    share_of_jump = np.where(strip_widths < distances_of_outermost, 1.0, _SHARE_SHOWN_BY_A_NODE)
    share_of_jump[strip_widths >= distances_of_rim] = 0.0
    tension_changes = share_of_jump * 4 / np.pi * jump_of_ratio * pressure_at_width
    return np.asarray(tension_changes.max(axis=0))


def _jumps_of_shear_ratio(
    solution: ContactSolution, first_step: int, last_step: int, ratio_at_rim: Array
) -> Array:
    """Jumps |c| of q/p between the newest strip of contact and the contact before each increment,
    at its left and right edge, (n_increments, 2), while P grows in full stick.

    An increment adds a strip in which q/p is dQ/dP of that increment. So before each increment but
    the first, q/p at the edge of contact is that of the strip before.

    Parameters
    ----------
    solution
        its loads P and Q at the stored steps
    first_step, last_step
        indices of the steps at which the growth of P began, and up to which it lasts
    ratio_at_rim
        (2,) q/p next to the left and right edge of contact before the first of these increments
    """
    p_increments = np.diff(solution.normal_load[first_step : last_step + 1])
    q_increments = np.diff(solution.tangential_load[first_step : last_step + 1])
    ratio_in_strips = q_increments / p_increments
    ratio_before = np.tile(np.append(np.nan, ratio_in_strips[:-1])[:, None], 2)
    ratio_before[0] = ratio_at_rim
    return np.abs(ratio_in_strips[-1] - ratio_before)


def _start_of_growth_in_stick(solution: ContactSolution, step: int) -> int:
    """Index of the stored step at which P began to grow in full stick, without a break up to a
    later one: `step` itself where P has not grown since the step before it, or where the contact
    does not stick in full.
    """
    p_increments = np.diff(solution.normal_load[: step + 1])
    first_step = step
    while (
        first_step > 0
        and p_increments[first_step - 1] > 0
        and _sticks_in_full(solution, first_step)
    ):
        first_step -= 1
    return first_step


def _sticks_in_full(solution: ContactSolution, step: int) -> bool:
    """Whether all of the contact sticks at a stored step: stick edges equal contact edges."""
    return bool(np.array_equal(solution.stick_edges[step], solution.contact_edges[step]))


class _EdgeTension(NamedTuple):
    """Stress s_xx along the faces at the edges of contact, its uncertainty, and its possible change
    by slip in a zone too narrow for the nodes.

    Each is (n_steps, 2, 2) by body and edge [stress].
    """

    values: Array
    uncertainties: Array
    tension_change_by_unseen_slip: Array


def _edge_tension(solution: ContactSolution, steps: Sequence[int]) -> _EdgeTension:
    """Stress s_xx along each face just outside each edge of contact, with its uncertainty and its
    possible change by slip in a zone too narrow for the nodes.

    The tractions cause opposite tensions in the two half-planes; bulk stress and the finite size of
    each body add to them. Arrays are (n_steps, 2, 2) by body and edge. Where P = 0 all are 0. Where
    fewer than three nodes touch under a load, or it is not known what the size of a body adds,
    values and uncertainties are NaN.

    Parameters
    ----------
    solution
        by finite elements or by kernels
    steps
        (n_steps,) indices of stored instants
    """
    tension = np.zeros((len(steps), 2, 2))
    uncertainties = np.zeros((len(steps), 2, 2))
    tension_changes_by_unseen_slip = np.zeros((len(steps), 2, 2))

    # Tension that the tractions alone cause, of opposite sign in the two half-planes.
    tractions_in_contact: dict[int, Tractions] = {}  # by position in `steps`
    for k, step in enumerate(steps):
        # sine series of p and q, and how uncertain the tension (2,) at both edges is by the fit
        fit_of_step = tractions_with_uncertainty(_nodal_tractions(solution, step))
        if fit_of_step.tractions is not None:
            tractions_in_contact[k] = fit_of_step.tractions
            # lower body, then upper one
            tension[k] = np.outer([1.0, -1.0], fit_of_step.tractions.edge_tension())
            uncertainties[k] = fit_of_step.tension_uncertainty
            tension_changes_by_unseen_slip[k] = fit_of_step.tension_change_by_unseen_slip
        elif solution.normal_load[step] > 0:
            tension[k] = math.nan
            uncertainties[k] = math.nan

    # Tension by bulk stress and by the finite size of the bodies.
    if tractions_in_contact:
        positions = list(tractions_in_contact)
        added_tension, added_uncertainty = _added_edge_tension(
            solution, [steps[k] for k in positions], list(tractions_in_contact.values())
        )
        tension[positions] += added_tension
        uncertainties[positions] += added_uncertainty[:, None]
    return _EdgeTension(tension, uncertainties, tension_changes_by_unseen_slip)


def _added_edge_tension(
    solution: ContactSolution, steps: Sequence[int], tractions_at_steps: Sequence[Tractions]
) -> tuple[Array, Array]:
    """Stress s_xx along both faces at the edges of contact that bulk stress and the finite size of
    the bodies add to that of half-planes.

    Parameters
    ----------
    solution
        by finite elements, or by kernels: then `solution.kernels` holds those of both bodies
    steps
        (n_steps,) indices of stored instants
    tractions_at_steps
        tractions on the lower body at each step, as sine series over the contact

    Returns
    -------
    values, uncertainties
        (n_steps, 2, 2) by body and edge, and (2,) by body [stress]; NaN for a body of finite size
        of which there is neither a fit beside the contact nor kernels (displacements of its face
        by unit forces, minus those of a half-plane)
    """
    bodies = solution.scene.bodies  # shapes of the lower and the upper body
    added_tension = np.zeros((len(steps), 2, 2))
    uncertainties = np.zeros(2)
    bulk_stresses = [_bulk_stress(solution, steps, body_number) for body_number in (0, 1)]
    size_fits = _size_fits_of_bodies(solution, steps, tractions_at_steps, bulk_stresses)
    # _BODY_NAMES: "lower", "upper"
    for body_number, name in enumerate(_BODY_NAMES):
        # To a half-plane only the bulk stress adds.
        if isinstance(getattr(bodies, name), HalfPlane):
            added_tension[:, body_number] = bulk_stresses[body_number][:, None]
            continue

        # Tension by the size of the body under the tractions on it, in its own frame.
        tractions_on_body = [
            _tractions_on_body(step_tractions, body_number) for step_tractions in tractions_at_steps
        ]
        size_fit = size_fits[body_number]
        if size_fit is not None:
            # the fit has the bulk stress in it, as the elements have
            added_tension[:, body_number] = size_fit.tension(
                tractions_on_body, bulk_stresses[body_number]
            )
            uncertainties[body_number] = size_fit.uncertainty
            continue
        kernels = _kernels_of_body(solution, body_number)
        if kernels is not None:
            added_tension[:, body_number], uncertainties[body_number] = _size_tension_by_kernels(
                kernels, getattr(solution.scene.material, name), tractions_on_body
            )
        else:
            added_tension[:, body_number] = math.nan
            uncertainties[body_number] = math.nan
    return added_tension, uncertainties


def _size_fits_of_bodies(
    solution: ContactSolution,
    steps: Sequence[int],
    tractions_at_steps: Sequence[Tractions],
    bulk_stresses: Sequence[Array],
) -> list[_SizeFit | None]:
    """Fits of the stress that the finite size of the lower and of the upper body adds beside the
    contact. None for a half-plane, for a body with a support or side too near the contact, and for
    a solution by kernels, which has no stress of elements.

    Two bodies that mirror each other have one fit, which is made once.

    Parameters
    ----------
    solution
        by finite elements or by kernels
    steps
        (n_steps,) indices of stored instants
    tractions_at_steps
        tractions on the lower body at each step, as sine series over the contact
    bulk_stresses
        of the lower and of the upper body, (n_steps,) each [stress]
    """
    if not isinstance(solution, FiniteElementSolution):
        return [None, None]
    bodies = solution.scene.bodies
    has_bulk_stress = any(bulk_stress.any() for bulk_stress in bulk_stresses)
    are_mirrored = (
        bodies.lower == bodies.upper and solution.scene.material.alike and not has_bulk_stress
    )
    size_fits: list[_SizeFit | None] = []
    # _BODY_NAMES: "lower", "upper"
    for body_number, name in enumerate(_BODY_NAMES):
        if isinstance(getattr(bodies, name), HalfPlane):
            size_fits.append(None)
        elif body_number == 1 and are_mirrored:
            size_fits.append(size_fits[0])
        else:
            size_fits.append(
                _size_fit(
                    solution, body_number, steps, tractions_at_steps, bulk_stresses[body_number]
                )
            )
    return size_fits


def _kernels_of_body(solution: ContactSolution, body_number: int) -> BodyKernels | None:
    """Kernels of the lower (0) or upper (1) body: what its finite size adds to the displacement of
    its face by unit forces. None where they are not known.

    A solution by kernels carries them; those of thin bodies of other solutions are computed.
    """
    if isinstance(solution, KernelSolution):
        # _BODY_NAMES: "lower", "upper"
        kernels: BodyKernels | None = getattr(solution.kernels, _BODY_NAMES[body_number])
        return kernels
    assert isinstance(solution, FiniteElementSolution)  # for the type checker
    return _kernels_of_thin_body(solution, body_number)


def _kernels_of_thin_body(solution: FiniteElementSolution, body_number: int) -> BodyKernels | None:
    """Kernels of one body over the part of its face that may touch: what its finite size adds to
    the displacement of the face by unit forces. None for a body of which they are not known.

    They take two linear solves on coarse meshes, about half a second; those of the last two bodies
    that were asked for are cached. Bodies that mirror each other have those of the lower one.

    Parameters
    ----------
    solution
        its scene, and the places `x` of its contact nodes, which span the part that may touch
    body_number
        0 of the lower body, 1 of the upper one
    """
    scene = solution.scene
    largest_x = float(np.abs(solution.x).max())
    return _flat_body_kernels(scene, 0 if bodies_are_alike(scene) else body_number, largest_x)


@lru_cache(maxsize=2)
def _flat_body_kernels(scene: Scene, body_number: int, largest_x: float) -> BodyKernels | None:
    """Kernels of the lower (0) or upper (1) body over |x| <= `largest_x` [length]: what its finite
    size adds to the displacement of its face by unit forces.

    None where no kernels are derived: for a curved face, a path with bulk stress, free sides on
    rollers, or a body so thin that the kernels need a polynomial of too high a degree.
    """
    # _BODY_NAMES: "lower", "upper"
    name = _BODY_NAMES[body_number]
    # Distance from a force at which a half-plane's surface has no displacement.
    datum_length = max(scene.profile.datum_length, largest_x)
    work_counts: Counter[str] = Counter()  # counts of meshes and solves, not reported
    # Both calls raise InputError for a body whose kernels are not derived.
    try:
        require_known_effects(name, getattr(scene.bodies, name), scene)
        return body_kernels(scene, name, largest_x, datum_length, work_counts)
    except InputError:
        return None


def _size_tension_by_kernels(
    kernels: BodyKernels, material: Elastic, tractions_on_body: Sequence[Tractions]
) -> tuple[Array, float]:
    """Stress s_xx at both edges of contact that the finite size of a flat-faced body adds to that
    of a half-plane, (n_steps, 2) [stress]. Its uncertainty is the largest difference of s_xx
    between the kernels of a fine and of a coarse mesh, of all steps [stress].

    It is E/(1 - nu^2) times the strain along the face, since no pressure acts beside the contact.
    The strain is that by the tractions, as forces at Gauss-Chebyshev points over the contact.

    Parameters
    ----------
    kernels
        displacements of the face of the body by unit forces on it, minus those of a half-plane
    material
        of the body
    tractions_on_body
        tractions on the body in its own frame at each step, as sine series over the contact
    """
    plane_strain_modulus = material.young_modulus / (1 - material.poisson_ratio**2)
    tension = np.zeros((len(tractions_on_body), 2))
    uncertainty = 0.0
    for k, step_tractions in enumerate(tractions_on_body):
        # (2,) strain along the face at both edges, and its difference between the two meshes
        strain, strain_difference = kernels.strain(
            np.array(step_tractions.edges), *_point_forces(step_tractions)
        )
        tension[k] = plane_strain_modulus * strain
        uncertainty = max(uncertainty, plane_strain_modulus * float(strain_difference.max()))
    return tension, uncertainty


def _point_forces(tractions_on_body: Tractions) -> tuple[Array, Array, Array]:
    """Tractions on a body as forces at 128 Gauss-Chebyshev points over the contact: places x
    [length], pressing forces and shear forces [force per thickness], (128,) each.

    p and q are sums of sines of the angle; a force is their value times the length that the point
    has in the contact.
    """
    angles = math.pi * (np.arange(_N_ANGLES) + 0.5) / _N_ANGLES
    x_in_contact = tractions_on_body.middle - tractions_on_body.half_width * np.cos(angles)
    point_lengths = tractions_on_body.half_width * np.sin(angles) * math.pi / _N_ANGLES
    pressing_forces, shear_forces = (
        np.sin(np.outer(angles, np.arange(1, len(sine_coefficients) + 1)))
        @ sine_coefficients
        * point_lengths
        for sine_coefficients in (
            tractions_on_body.pressure_coefficients[:_N_ANGLES],
            tractions_on_body.shear_coefficients[:_N_ANGLES],
        )
    )
    return x_in_contact, pressing_forces, shear_forces


@dataclass(frozen=True, eq=False)
class _SizeFit:
    """Stress that the finite size of a body adds, as a linear function of moments of its tractions
    and of its bulk stress: the predictors of the regression.

    Attributes
    ----------
    size_effect
        at the instants to which it is fitted
    regression_matrix
        (n_predictors, n_coefficients) coefficients of the size effect by a unit of each predictor
    predictor_units
        (n_predictors,) unit of each predictor
    uncertainty
        of s_xx at an edge [stress]
    """

    size_effect: SizeEffect
    regression_matrix: Array
    predictor_units: Array
    uncertainty: float

    @classmethod
    def by_regression(
        cls, size_effect: SizeEffect, predictors: Array, predictor_units: Array
    ) -> _SizeFit:
        """Least-squares regression of the coefficients of a size effect on its predictors.

        The uncertainty is the standard error of s_xx at an edge, plus what the regression misses of
        s_xx at the middle of the face, x = y = 0; of both the largest at the sampled steps.

        Parameters
        ----------
        size_effect
            fitted series of the stress that the size of the body adds at the sampled steps
        predictors
            (n_sampled, n_predictors) moments of the tractions, then the bulk stress, at these steps
        predictor_units
            (n_predictors,) unit of each predictor
        """
        regression_matrix = np.linalg.lstsq(
            predictors / predictor_units, size_effect.coefficients.T, rcond=1e-8
        )[0]
        size_fit = cls(
            size_effect,
            np.asarray(regression_matrix, dtype=float),
            predictor_units,
            uncertainty=0.0,
        )
        origin = np.zeros(1)
        stress_by_regression = size_fit.size_effect_of(predictors).stress(origin, origin)
        stress_missed = size_effect.stress(origin, origin) - stress_by_regression
        uncertainty = float(size_effect.error.max() + np.abs(stress_missed[:, 0]).max())
        return replace(size_fit, uncertainty=uncertainty)

    def tension(self, tractions_on_body: Sequence[Tractions], bulk_stress: Array) -> Array:
        """Stress s_xx (n_steps, 2) that the finite size of a body adds at both edges of contact
        [stress], by the regression on moments of its tractions and on its bulk stress.

        Parameters
        ----------
        tractions_on_body
            tractions on the body in its own frame at each step; their `edges` are those of contact
        bulk_stress
            (n_steps,) of the body; no predictor where it is 0 all along [stress]
        """
        size_effect = self.size_effect_of(
            _predictors(tractions_on_body, bulk_stress)[:, : len(self.predictor_units)]
        )
        y_of_face = np.zeros(2)
        tensions = [
            size_effect.stress(np.array(step_tractions.edges), y_of_face)[:, 0, k]
            for k, step_tractions in enumerate(tractions_on_body)
        ]
        return np.array(tensions)

    def size_effect_of(self, predictors: Array) -> SizeEffect:
        """Stress that the finite size of a body adds at n_steps instants, as a fitted series whose
        coefficients are linear in the predictors (n_steps, n_predictors): moments of the tractions
        on the body, then its bulk stress.
        """
        return replace(
            self.size_effect,
            coefficients=(predictors / self.predictor_units @ self.regression_matrix).T,
        )


def _predictors(tractions_on_body: Sequence[Tractions], bulk_stress: Array) -> Array:
    """Predictors (n_steps, 7) of the stress that the finite size of a body adds: six moments of the
    tractions on it, int p x^k dx and int q x^k dx for k = 0, 1, 2, and its bulk stress (n_steps,).
    """
    moments = np.array([step_tractions.moments() for step_tractions in tractions_on_body])
    return np.column_stack([moments, bulk_stress])


def _size_fit(
    solution: FiniteElementSolution,
    body_number: int,
    steps: Sequence[int],
    tractions_at_steps: Sequence[Tractions],
    bulk_stress: Array,
) -> _SizeFit | None:
    """Linear regression of the stress that the finite size of a body adds beside the contact; the
    predictors are moments of the tractions and the bulk stress.

    That stress is element stress minus half-plane stress at up to a dozen steps, spread evenly; the
    regression gives it at all others. None where a support or side is too near the contact.

    Parameters
    ----------
    solution
        by finite elements
    body_number
        0 of the lower body, 1 of the upper one
    steps
        (n_steps,) indices of stored instants
    tractions_at_steps
        tractions on the lower body at each step, as sine series over the contact
    bulk_stress
        (n_steps,) of this body [stress]
    """
    half_width = max(step_tractions.half_width for step_tractions in tractions_at_steps)
    # _BODY_NAMES: "lower", "upper"
    shape = getattr(solution.scene.bodies, _BODY_NAMES[body_number])
    if _distance_of_fit(shape, half_width) is None:
        return None
    # _N_SAMPLED_STEPS: twelve
    spread_positions = np.linspace(0, len(steps) - 1, _N_SAMPLED_STEPS).round().astype(int)
    sampled_positions = sorted(set(spread_positions.tolist()))  # positions in `steps`
    size_effect = _size_effect_at_steps(
        solution,
        body_number,
        [steps[k] for k in sampled_positions],
        [tractions_at_steps[k] for k in sampled_positions],
        bulk_stress[sampled_positions],
    )
    if size_effect is None:
        return None

    predictors = _predictors(
        [_tractions_on_body(step_tractions, body_number) for step_tractions in tractions_at_steps],
        bulk_stress,
    )
    # units (n_predictors,): without bulk stress, which is the last column, one fewer than columns
    predictor_units = _predictor_units(predictors, half_width)
    return _SizeFit.by_regression(
        size_effect, predictors[sampled_positions, : len(predictor_units)], predictor_units
    )


def _predictor_units(predictors: Array, half_width: float) -> Array:
    """Unit of each predictor of the stress that the size of a body adds: P and powers of the
    contact half-width for the six moments, so that moments which are zero by symmetry do not count
    as round-off over round-off; the largest bulk stress for the last one, (6,) or (7,).

    `predictors` (n_steps, 7) are six moments of the tractions, the first of them P, and the bulk
    stress. Where that is 0 at all steps it is no predictor, and has no unit. `half_width` is the
    largest one [length].
    """
    moment_units = np.abs(predictors[:, 0]).max() * half_width ** np.array([0, 1, 2, 0, 1, 2])
    bulk_stress = predictors[:, 6]
    if not bulk_stress.any():
        return np.asarray(moment_units)
    return np.append(moment_units, np.abs(bulk_stress).max())


def _size_effect_at_steps(
    solution: FiniteElementSolution,
    body_number: int,
    steps: Sequence[int],
    tractions_at_steps: Sequence[Tractions | None],
    bulk_stress: Array,
) -> SizeEffect | None:
    """Stress that the finite size of a body adds beside the contact at some steps, as a series that
    is fitted to the stress of its elements minus that of a half-plane.

    None for a half-plane, where a support or side is too near the contact, and where at no step
    three nodes touch.

    Parameters
    ----------
    solution
        by finite elements
    body_number
        0 of the lower body, 1 of the upper one
    steps
        (k,) indices of stored instants
    tractions_at_steps
        (k,) tractions on the lower body, as sine series; None where fewer than three nodes touch
    bulk_stress
        (k,) of this body [stress]
    """
    nodal_fields = _nodal_fields(solution, body_number, steps, bulk_stress)
    region_near_contact = _near_contact(solution, body_number, nodal_fields, tractions_at_steps)
    return None if region_near_contact is None else region_near_contact.size_effect


def stress(
    solution: FiniteElementSolution,
    x: ArrayLike,
    y: ArrayLike,
    instants: ArrayLike,
    *,
    body: Literal["lower", "upper"] = "lower",
) -> Array:
    """Stress at any place next to the contact in one body, from the surface tractions of a
    finite-element solution.

    It is the stress that the tractions cause in a half-plane, plus bulk stress, plus a fitted
    correction for the finite size of the body. It resolves the edges of contact better than the
    elements do.

    Parameters
    ----------
    solution
        by finite elements
    x, y
        (n_points,) places [length]; y points out of the lower body and counts from the face, also
        from a curved one: y <= 0 in the lower body, y >= 0 in the upper one
    instants
        (n_instants,) times; the stored step nearest to each is taken
    body
        "lower" or "upper"

    Returns
    -------
    Array
        (n_instants, n_points, 4) s_xx, s_yy, s_xy and s_zz [stress]; NaN where fewer than three
        nodes touch under a load

    Raises
    ------
    InputError
        For a solution without meshes, an unknown body, an instant outside the solved time, or a
        place outside the body. In a body of finite size also for a place that is further than three
        half-widths from the contact, or close to a support or side, or with bulk stress where
        nothing touches: `fields` has the stress there.
    """
    _require_meshes("stress", solution)
    # _BODY_NAMES: "lower", "upper"
    if body not in _BODY_NAMES:
        raise InputError(f"stress: body is lower or upper, not {body!r}")
    body_number = _BODY_NAMES.index(body)
    instant_times = np.atleast_1d(np.asarray(instants, dtype=float))
    # indices of the stored instants
    steps = [_nearest_step("stress", solution, float(instant)) for instant in instant_times]
    x_in_body, y_in_body = _places_in_body(x, y, body_number)

    # s_xx, s_yy, s_xy in the frame of this body. The tractions are sine series of p and q on the
    # lower body; None of steps at which fewer than three nodes touch.
    tractions_at_steps = _tractions_at_steps(solution, steps)
    stress_at_places = np.zeros((len(steps), len(x_in_body), 4))
    stress_at_places[..., :3] = _stress_next_to_contact(
        solution, body_number, steps, tractions_at_steps, x_in_body, y_in_body
    )

    # Into the common frame, with s_zz of plane strain.
    stress_at_places[..., 2] *= _sign_of_y(body_number)  # s_xy changes its sign with y
    poisson_ratio = solution.condensed_bodies[body_number].material.poisson_ratio
    stress_at_places[..., 3] = poisson_ratio * (stress_at_places[..., 0] + stress_at_places[..., 1])
    for k, step in enumerate(steps):
        if tractions_at_steps[k] is None and solution.normal_load[step] > 0:
            stress_at_places[k] = math.nan
    return stress_at_places


def _stress_next_to_contact(
    solution: FiniteElementSolution,
    body_number: int,
    steps: Sequence[int],
    tractions_at_steps: Sequence[Tractions | None],
    x: Array,
    y: Array,
) -> Array:
    """Stress s_xx, s_yy, s_xy (n_steps, n_points, 3) at places next to the contact in one body, in
    its own frame [stress]: that of a half-plane under the tractions, plus bulk stress, plus what
    the finite size of the body adds.

    Parameters
    ----------
    solution
        by finite elements, with the shapes of the bodies
    body_number
        0 of the lower body, 1 of the upper one
    steps
        (n_steps,) indices of stored instants
    tractions_at_steps
        (n_steps,) tractions on the lower body, as sine series; None where fewer than three nodes
        touch
    x, y
        (n_points,) places in the body's own frame, y <= 0 inside [length]
    """
    tractions_on_body = _tractions_on_body_at_steps(tractions_at_steps, body_number)
    stress_of_tractions = _stress_of_tractions(tractions_on_body, x, y)
    stress_next_to_contact = np.moveaxis(stress_of_tractions, -1, 0).copy()

    # Bulk stress of a half-plane. In other bodies the fitted stress by their size contains it.
    # _BODY_NAMES: "lower", "upper"
    bulk_stress = _bulk_stress(solution, steps, body_number)  # (n_steps,)
    has_contact = any(step_tractions is not None for step_tractions in tractions_at_steps)
    if isinstance(getattr(solution.scene.bodies, _BODY_NAMES[body_number]), HalfPlane):
        stress_next_to_contact[..., 0] += bulk_stress[:, None]
    elif bulk_stress.any() or has_contact:
        stress_by_size = _stress_by_size(solution, body_number, steps, tractions_at_steps, x, y)
        stress_next_to_contact += np.moveaxis(stress_by_size, -1, 0)
    return stress_next_to_contact


def _places_in_body(x: ArrayLike, y: ArrayLike, body_number: int) -> tuple[Array, Array]:
    """Places in the lower (0) or upper (1) body in its own frame, in which y points out of it: x
    and y, (n_points,) each, from those in the common frame, whose y points out of the lower body
    [length]. InputError for a place outside the body.
    """
    sign_of_y = _sign_of_y(body_number)  # -1 of the upper body
    x_in_body, y_in_body = np.broadcast_arrays(
        np.atleast_1d(np.asarray(x, dtype=float)),
        np.atleast_1d(sign_of_y * np.asarray(y, dtype=float)),
    )
    if np.any(y_in_body > 0):
        raise InputError(
            f"stress: y = {sign_of_y * float(y_in_body.max()):.6g} is outside the"
            f" {_BODY_NAMES[body_number]} body; y points out of the lower one"
        )
    return x_in_body, y_in_body


def _stress_by_size(
    solution: FiniteElementSolution,
    body_number: int,
    steps: Sequence[int],
    tractions_at_steps: Sequence[Tractions | None],
    x: Array,
    y: Array,
) -> Array:
    """Stress s_xx, s_yy, s_xy (n_points, 3, n_steps) that the finite size of a body and its bulk
    stress add at places next to the contact [stress]: a series that is fitted to the stress of the
    elements minus that of a half-plane.

    Parameters
    ----------
    solution
        by finite elements
    body_number
        0 of the lower body, 1 of the upper one
    steps
        (n_steps,) indices of stored instants
    tractions_at_steps
        (n_steps,) tractions on the lower body, as sine series; None where fewer than three nodes
        touch
    x, y
        (n_points,) places in the body's own frame, y <= 0 inside [length]

    Raises
    ------
    InputError
        Where a support or side is too near the contact for a fit, or nothing touches at any step;
        for a place further from the contact than the fit reaches.
    """
    bulk_stress = _bulk_stress(solution, steps, body_number)
    size_effect = _size_effect_at_steps(
        solution, body_number, steps, tractions_at_steps, bulk_stress
    )
    # A place at the largest distance itself may be beyond it by rounding.
    if size_effect is None or np.any(np.hypot(x, y) > size_effect.length * (1 + 1e-9)):
        raise InputError(
            f"stress: a place in the {_BODY_NAMES[body_number]} body is further from the contact"
            " than where the tractions alone give its stress"
        )
    return size_effect.stress(x, y)


@dataclass(frozen=True)
class LargestTension:
    """The largest tension s_xx of a cycle at an edge of contact.

    Attributes
    ----------
    value, uncertainty
        of the tension [stress]
    time
        instant of it
    body
        "lower" or "upper"
    x
        place of the edge of contact where it is [length]
    edges
        left and right edge of contact at that time [length]
    """

    value: float
    uncertainty: float
    time: float
    body: str
    x: float
    edges: tuple[float, float]


def largest_edge_tension(solution: ContactSolution) -> LargestTension | None:
    """The largest tension s_xx of the last cycle of a solution, along either face just outside an
    edge of contact, with its place, time and uncertainty.

    None where at no instant of that cycle three nodes touch, and where it is not known what the
    size of a body adds to the stress of a half-plane. Just after a load reverses, the new slip zone
    is narrower than an element, so that the stress there is uncertain. A value from such an instant
    may be the largest by its error alone. So the instant, body and edge are those of the largest
    value minus its uncertainty. By how far another value is larger counts as uncertainty too.
    """
    require_solution(solution, "largest_edge_tension")
    if why_tension_is_unknown(solution) is not None:
        return None
    # Candidates: indices of up to some forty stored steps with the highest estimates of tension.
    steps = _steps_of_large_tension(solution)
    if not steps:
        return None

    candidates = _Candidates.at_steps(solution, steps)
    added_tension, added_uncertainty = _added_edge_tension(solution, steps, candidates.tractions)
    # s_xx at all candidates, (n_steps, 2, 2) by body and edge
    tension = candidates.tension_by_tractions() + added_tension
    if np.isnan(tension).any():
        return None

    def uncertainties_of(candidate_number: int) -> Array:
        """Uncertainty of s_xx at one candidate, (2, 2) by body and edge [stress]: that by the
        tractions of either edge and that by the size of either body.
        """
        change_by_new_contact = _tension_change_by_new_contact(solution, steps[candidate_number])
        uncertainty_by_tractions = candidates.uncertainty_by_tractions(
            candidate_number, change_by_new_contact
        )
        return np.asarray(added_uncertainty[:, None] + uncertainty_by_tractions)

    index_of_largest, uncertainty = _largest_with_uncertainty(tension, uncertainties_of)
    candidate_number, body_number, edge_number = index_of_largest
    edges = candidates.tractions[candidate_number].edges  # left and right edge of contact
    # _BODY_NAMES: "lower", "upper"
    return LargestTension(
        value=float(tension[index_of_largest]),
        uncertainty=uncertainty,
        time=float(solution.time[steps[candidate_number]]),
        body=_BODY_NAMES[body_number],
        x=edges[edge_number],
        edges=edges,
    )


def _largest_with_uncertainty(
    tension: Array, uncertainties_of: Callable[[int], Array]
) -> tuple[tuple[int, int, int], float]:
    """Index of the largest edge tension, by candidate, body and edge, and its
    uncertainty [stress].

    The index is that of the largest value minus its uncertainty, the first of equal ones. What
    another value exceeds it by is added to the uncertainty. A candidate is left out once its value
    alone is below the largest difference of both found so far.

    Parameters
    ----------
    tension
        (n_candidates, 2, 2) by body and edge [stress]
    uncertainties_of
        number of a candidate -> uncertainties (2, 2) of its values [stress]
    """
    largest_value = float(tension.max())
    # _ROUND_OFF: relative difference by round-off, 1e-9. Two halves of a cycle may mirror each
    # other but for it: the first instant is taken.
    round_off = _ROUND_OFF * abs(largest_value)
    largest_of_candidates = tension.max(axis=(1, 2))
    best_index = (0, 0, 0)
    best_uncertainty = math.inf
    best_lower_bound = -math.inf
    for candidate_number in np.argsort(-largest_of_candidates, kind="stable"):
        if largest_of_candidates[candidate_number] < best_lower_bound - round_off:
            break
        uncertainties = uncertainties_of(int(candidate_number))
        lower_bounds = tension[candidate_number] - uncertainties
        body_number, edge_number = (
            int(index) for index in np.unravel_index(np.argmax(lower_bounds), (2, 2))
        )
        lower_bound = float(lower_bounds[body_number, edge_number])
        tension_index = (int(candidate_number), body_number, edge_number)
        is_equal = abs(lower_bound - best_lower_bound) <= round_off
        if lower_bound > best_lower_bound + round_off or (is_equal and tension_index < best_index):
            best_index = tension_index
            best_lower_bound = lower_bound
            best_uncertainty = float(uncertainties[body_number, edge_number])
    return best_index, best_uncertainty + largest_value - float(tension[best_index])


class _Candidates(NamedTuple):
    """Tractions at the stored steps among which the largest edge tension is looked for, one of each
    for each step.

    Attributes
    ----------
    nodal_tractions
        pressure and shear at the nodes that touch
    tractions
        the same as sine series across the contact
    """

    nodal_tractions: Sequence[NodalTractions]
    tractions: Sequence[Tractions]

    @classmethod
    def at_steps(cls, solution: ContactSolution, steps: Sequence[int]) -> _Candidates:
        """Tractions of a solution at stored steps, at each of which three nodes or more touch."""
        nodal_tractions_at_steps = [_nodal_tractions(solution, step) for step in steps]
        return cls(
            nodal_tractions_at_steps,
            [tractions(nodal_tractions) for nodal_tractions in nodal_tractions_at_steps],
        )

    def tension_by_tractions(self) -> Array:
        """Tension s_xx at the edges of contact by the tractions on half-planes, (n_steps, 2, 2) by
        body and edge [stress]; it has opposite signs in the two bodies.
        """
        return np.array(
            [
                np.outer([1.0, -1.0], step_tractions.edge_tension())
                for step_tractions in self.tractions
            ]
        )

    def uncertainty_by_tractions(self, number: int, change_by_new_contact: Array) -> Array:
        """Uncertainty of s_xx at both edges of contact by the tractions of one candidate, (2,)
        [stress]: that of the fit, with its possible change by new contact (2,), or the possible
        change by slip that no node shows yet, whichever is larger.
        """
        fit = tractions_with_uncertainty(self.nodal_tractions[number])
        return np.maximum(
            fit.tension_uncertainty + change_by_new_contact, fit.tension_change_by_unseen_slip
        )


def why_tension_is_unknown(solution: ContactSolution) -> str | None:
    """Reason in words why the largest tension s_xx at the edges of contact is not known of a
    solution; None where neither body is the reason. No fit is made to find it.

    The stress that the finite size of each body adds on its face must be known: by a fit beside the
    contact, for which its supports and sides must be far enough away, or by kernels (displacements
    of its face by unit forces, minus those of a half-plane).
    """
    # Answers that were read back from disk have neither meshes nor kernels.
    if not _has_data_of_size_effect(solution):
        return "the answer has no meshes, which the stress of its bodies needs"
    if not isinstance(solution, FiniteElementSolution):
        return None
    half_width = float(solution.contact_half_width[solution.last_cycle].max())
    # _BODY_NAMES: "lower", "upper"
    for body_number, name in enumerate(_BODY_NAMES):
        shape = getattr(solution.scene.bodies, name)
        if isinstance(shape, HalfPlane) or _distance_of_fit(shape, half_width) is not None:
            continue
        if _kernels_of_thin_body(solution, body_number) is None:
            reason = _why_no_kernels(shape, solution.scene)
            # _LEAST_ROOM: fewest half-widths from the middle of the contact to a side or support
            return (
                f"the {name} body ends within {_LEAST_ROOM:.2g} half-widths of the contact's middle"
                f" and {reason}"
            )
    return None


def _why_no_kernels(shape: Shape, scene: Scene) -> str:
    """What keeps the kernels of a body from being known, in words that follow its name in a
    message: a curved face, bulk stress, rollers with free sides, or else its thinness.
    """
    if not isinstance(shape, Block | TShape):
        return "its face is curved"
    if not scene.load.is_driven and has_bulk_stress(scene.load.path()):
        return "a bulk stress pulls it"
    if isinstance(shape, Block) and shape.base == "rollers" and shape.sides == "free":
        return "its rollers hold no tangential load"
    return "is thinner than its kernels are known for"


def _steps_of_large_tension(solution: ContactSolution) -> list[int]:
    """Candidates for the instant of the largest edge tension: indices of the steps of the last
    cycle, in order of time, at which an estimate of it is highest. Empty where no step has three
    nodes in contact.

    The estimate is the tension by tractions that are fitted at few points, plus the tension that
    bulk stress and body size add, interpolated in time. Fits cost most: they are made in the order
    of a cheaper bound by nodal tractions, until no step left can be among the highest.

    Between half-planes without bulk stress the estimate is exact, and one candidate is enough;
    else there are forty.
    """
    # Larger tension of both edges by nodal tractions, at each step of the last cycle with three
    # nodes in contact.
    steps_of_cycle = [int(step) for step in solution.last_cycle]
    nodal_tractions = {step: _nodal_tractions(solution, step) for step in steps_of_cycle}
    # FEWEST_NODES: 3
    nodal_tension = {
        step: edge_tension_by_nodal_shear(tractions_of_step)
        for step, tractions_of_step in nodal_tractions.items()
        if len(tractions_of_step.x) >= FEWEST_NODES
    }
    has_bulk_stress = any(
        _bulk_stress(solution, steps_of_cycle, body_number).any() for body_number in (0, 1)
    )
    is_exact = solution.scene.bodies.half_planes and not has_bulk_stress
    n_candidates = 1 if is_exact else _N_CANDIDATE_STEPS
    if len(nodal_tension) <= n_candidates:
        return list(nodal_tension)

    # Tension by bulk stress and body size: by step, (2, 2) by body and edge of contact.
    added_tension = dict.fromkeys(nodal_tension, np.zeros((2, 2)))
    if not is_exact:
        added_tension = _interpolated_added_tension(
            solution, {step: nodal_tractions[step] for step in nodal_tension}
        )
    # _LARGEST_RATIO_TO_NODAL: largest tension by fits over that by nodal tractions, 1.3
    upper_bounds = {
        step: _LARGEST_RATIO_TO_NODAL * tension + float(added_tension[step].max())
        for step, tension in nodal_tension.items()
    }

    def estimate_by_fit(step: int) -> float:
        """Largest tension of both bodies and edges at a stored step, by tractions that are fitted
        at few points [stress].
        """
        # (2,) of the lower body, at the left and right edge of contact
        tension_by_tractions = sampled_tractions(nodal_tractions[step]).edge_tension()
        # the tractions on the upper body are opposite, and so is the tension that they cause
        tension_estimates = np.outer([1.0, -1.0], tension_by_tractions) + added_tension[step]
        return float(tension_estimates.max())

    highest_steps = _steps_of_highest_estimates(upper_bounds, estimate_by_fit, n_candidates)
    return [step for step in steps_of_cycle if step in highest_steps]


def _steps_of_highest_estimates(
    upper_bounds: Mapping[int, float], estimate_at_step: Callable[[int], float], n_highest: int
) -> set[int]:
    """Steps with the `n_highest` highest estimates of tension, and those that equal the lowest of
    these but for round-off. There are at least `n_highest` steps.

    Estimates are made in the order of the upper bounds, the highest first, until no bound that is
    left exceeds the lowest estimate that counts.

    Parameters
    ----------
    upper_bounds
        index of a stored step -> upper bound of its estimate [stress]
    estimate_at_step
        estimate at a step, given its index [stress]
    n_highest
        number of estimates to find
    """
    estimates: dict[int, float] = {}
    for step in sorted(upper_bounds, key=lambda step: -upper_bounds[step]):
        highest_estimates = sorted(estimates.values(), reverse=True)[:n_highest]
        if len(highest_estimates) == n_highest and upper_bounds[step] < highest_estimates[-1]:
            break
        estimates[step] = estimate_at_step(step)
    highest_estimates = sorted(estimates.values(), reverse=True)[:n_highest]

    # Instants that are alike but for round-off are all candidates, or none.
    # _ROUND_OFF: relative difference by round-off, 1e-9
    least_estimate = highest_estimates[-1] * (1 - _ROUND_OFF)
    return {step for step, tension in estimates.items() if tension >= least_estimate}


def _interpolated_added_tension(
    solution: ContactSolution, nodal_tractions: Mapping[int, NodalTractions]
) -> dict[int, Array]:
    """Estimate of the tension s_xx that bulk stress and the size of the bodies add at the edges of
    contact. For the index of each stored step it is (2, 2) by body and edge [stress].

    It is computed at six steps and interpolated in time by a cubic spline; 0 where it is not known.

    Parameters
    ----------
    solution
        by finite elements or by kernels; `time` holds the instant of each stored step
    nodal_tractions
        index of a stored step -> pressure and shear at the nodes that touch then
    """
    steps = list(nodal_tractions)
    # _N_SAMPLED_STEPS_OF_SEARCH: 6
    evenly_spread_positions = (
        np.linspace(0, len(steps) - 1, _N_SAMPLED_STEPS_OF_SEARCH).round().astype(int)
    )
    sampled_steps = [steps[k] for k in evenly_spread_positions]
    tractions_at_steps = [tractions(nodal_tractions[step]) for step in sampled_steps]
    sampled_tensions, _ = _added_edge_tension(solution, sampled_steps, tractions_at_steps)
    spline = scipy.interpolate.CubicSpline(
        solution.time[sampled_steps], np.nan_to_num(sampled_tensions)
    )
    return dict(zip(steps, spline(solution.time[steps]), strict=True))


def _bulk_stress(solution: ContactSolution, steps: Sequence[int], body_number: int) -> Array:
    """Bulk stress (n_steps,) of the lower (0) or the upper (1) body [stress]."""
    bulk_stress = (solution.bulk_stress_lower, solution.bulk_stress_upper)[body_number]
    if bulk_stress is None:
        return np.zeros(len(steps))
    return np.asarray(bulk_stress[list(steps)])


def _nodal_tractions(solution: ContactSolution, step: int) -> NodalTractions:
    """Pressure and shear at the touching nodes of a solution at a stored step, with what a fit of
    sine series needs: edges of stick and contact, friction, Q, kinks of the profile.

    Q is the load, or on curved faces the resultant of the nodal shear, as p carries a part of Q
    there. Also whether a body is of finite size, and whether the materials differ.

    Parameters
    ----------
    solution
        used are its tractions, loads, edges of contact and stick at the step, and the scene:
        friction, profile, and bodies, whose `faces_are_true` where curved faces are meshed as such
    step
        index of a stored instant
    """
    pressure = solution.pressure[step]
    shear = solution.shear[step]
    friction = solution.scene.friction.coefficient
    # A node that just meets or leaves the other face has no pressure but round-off, up to 1e-9 of
    # the largest: it counts as open.
    is_closed = pressure > _NEGLIGIBLE_PRESSURE * np.max(pressure)
    tangential_load = float(solution.tangential_load[step])
    if solution.scene.bodies.faces_are_true and isinstance(solution, FiniteElementSolution):
        tangential_load = float(shear @ solution.face_lengths)
    step_before = max(step - 1, 0)
    rise_of_normal_load = float(solution.normal_load[step] - solution.normal_load[step_before])
    rise_of_tangential_load = float(
        solution.tangential_load[step] - solution.tangential_load[step_before]
    )
    left_stick_edge, right_stick_edge = solution.stick_edges[step].tolist()
    left_contact_edge, right_contact_edge = solution.contact_edges[step].tolist()
    return NodalTractions(
        x=solution.x[is_closed],
        pressure=pressure[is_closed],
        shear=shear[is_closed],
        stick_edges=(left_stick_edge, right_stick_edge),
        contact_edges=(left_contact_edge, right_contact_edge),
        friction=friction,
        tangential_load=tangential_load,
        # Whether the contact grows in full stick. With bulk stress or tilt each edge moves by a law
        # of its own: False then, which makes the uncertainty larger, not smaller.
        load_grows_in_stick=rise_of_normal_load > 0
        and abs(rise_of_tangential_load) <= friction * rise_of_normal_load
        and solution.tilt is None,
        curvature_jumps=profile_kinks(solution.scene),
        has_tabulated_profile=isinstance(solution.scene.profile, Tabulated),
        has_real_bodies=not solution.scene.bodies.half_planes,
        has_unlike_materials=not solution.scene.material.alike,
    )


def profile_kinks(scene: Scene) -> Array:
    """Places x where the curvature of the profile jumps, and the contact modulus E* times the
    jump: (k, 2), left side subtracted from right [length, stress/length].

    Curvatures on either side are second differences of the height h with a spacing of a thousandth
    of the place. Each kink at x > 0 has its mirror image at -x.
    """
    places_and_jumps = []
    for place in scene.profile.kinks:  # x > 0 of each jump of the curvature
        # _STEP_AT_KINK: 1e-3
        spacing = _STEP_AT_KINK * place
        height_far_left, height_left, height_middle, height_right, height_far_right = (
            scene.profile.height(place + spacing * np.arange(-2, 3))
        )
        second_difference_left = height_far_left - 2 * height_left + height_middle
        second_difference_right = height_middle - 2 * height_right + height_far_right
        curvature_jump = (second_difference_right - second_difference_left) / spacing**2
        places_and_jumps += [(place, curvature_jump), (-place, -curvature_jump)]
    e_star = contact_modulus(scene.material.lower, scene.material.upper)
    return np.array(places_and_jumps).reshape(-1, 2) * [1.0, e_star]


@dataclass(frozen=True, eq=False)
class _NodalFields:
    """Displacement and stress by elements at the n nodes of a body at k stored steps, in the body's
    own frame, whose y points out of it.

    The bulk stress of a body of finite size is in both; that of a half-plane is not.

    Attributes
    ----------
    basis
        of the displacement
    displacement
        (n_dofs, k) [length]
    stress
        (n, 4, k) xx, yy, xy, zz [stress]
    """

    basis: skfem.Basis
    displacement: Array
    stress: Array


def _nodal_fields(
    solution: FiniteElementSolution, body_number: int, steps: Sequence[int], bulk_stress: Array
) -> _NodalFields:
    """Displacement and stress at the nodes of one body by its elements, at k stored steps, in the
    body's own frame, whose y points out of it.

    Displacements of a half-plane are relative to its surface at the datum length from the contact.

    Parameters
    ----------
    solution
        used are its condensed bodies (mesh and material) and the nodal contact forces of its
        interface states, in units of `solution.scales.load`
    body_number
        0 of the lower body, 1 of the upper one
    steps
        (k,) indices of the steps
    bulk_stress
        (k,) of this body at the steps [stress]
    """
    condensed_body = solution.condensed_bodies[body_number]
    # Contact forces p and q of the nodes (n, k), then those on this body in its own frame.
    contact_states = [solution.states[step] for step in steps]
    normal_forces = (
        np.stack([state.pressure for state in contact_states], axis=1) * solution.scales.load
    )
    tangential_forces = (
        np.stack([state.shear for state in contact_states], axis=1) * solution.scales.load
    )
    # _BODY_NAMES: "lower", "upper"
    forces_on_body = body_forces(*solution.condensed_bodies, normal_forces, tangential_forces)[
        _BODY_NAMES[body_number]
    ]

    # Displacement of all nodes (n_dofs, k) under them. Mixed elements have a further unknown, the
    # mixed pressure at their corners, (n_corners, k): a part of every normal stress.
    basis, displacements, mixed_pressures = displacement_fields(
        condensed_body, forces_on_body, solution.scene.profile.datum_length, bulk_stress
    )

    # Stress of the elements, averaged at the nodes.
    stresses = []
    for displacement, mixed_pressure in zip(displacements.T, mixed_pressures.T, strict=True):
        stresses.append(_nodal_stress(basis, displacement, mixed_pressure, condensed_body))
    return _NodalFields(basis, displacements, np.stack(stresses, axis=-1))


@dataclass(frozen=True, eq=False)
class _NearContact:
    """The part of a body next to the contact, where its stress is that of the tractions.

    Attributes
    ----------
    largest_distance
        of its nodes from the middle of the contact [length]
    nodes
        (m,) numbers of the nodes in it
    x, y
        (m,) their places, y counted from the face, as if that were flat [length]
    tractions
        (k,) tractions on this body at the k steps, in its own frame; None where fewer than three
        nodes touch
    size_effect
        stress that the finite size of the body adds; None of a half-plane
    """

    largest_distance: float
    nodes: Indices
    x: Array
    y: Array
    tractions: Sequence[Tractions | None]
    size_effect: SizeEffect | None


def _near_contact(
    solution: FiniteElementSolution,
    body_number: int,
    nodal_fields: _NodalFields,
    tractions_at_steps: Sequence[Tractions | None],
) -> _NearContact | None:
    """Nodes of a body within three half-widths of the middle of the contact, with the tractions on
    the body and a fit of the stress that its finite size adds there.

    There stress follows from the tractions more accurately than from the elements. The fit uses
    nodes deep enough, or far enough beside the contact, for the elements to be accurate. Where a
    support or side is near, the distance is shorter. None where it is too short for a fit, and
    where at no step three nodes touch.

    Parameters
    ----------
    solution
        its scene, with the shapes of the bodies and the profile of their faces
    body_number
        0 of the lower body, 1 of the upper one
    nodal_fields
        by the elements: stress (n, 4, k) at the nodes of this body at k steps, their mesh
        (`basis.mesh`)
    tractions_at_steps
        (k,) tractions on the lower body at the steps, as sine series; None where fewer than three
        nodes touch
    """
    # Distance from the middle of the contact up to which stress is that of the tractions.
    # _BODY_NAMES: "lower", "upper"
    shape = getattr(solution.scene.bodies, _BODY_NAMES[body_number])
    half_widths = [
        step_tractions.half_width
        for step_tractions in tractions_at_steps
        if step_tractions is not None
    ]
    if not half_widths:
        return None
    half_width = max(half_widths)
    largest_distance = _distance_of_fit(shape, half_width)
    if largest_distance is None:
        return None

    # Nodes within it, and the tractions on this body.
    x_of_mesh, y_of_mesh = nodal_fields.basis.mesh.p
    # `depth`: of the face below its highest point
    depth_of_face = face_of(shape, solution.scene.profile).depth(np.abs(x_of_mesh))
    y_from_face = np.minimum(y_of_mesh + depth_of_face, 0.0)  # y <= 0 as if the face were flat
    nodes = np.flatnonzero(np.hypot(x_of_mesh, y_from_face) < largest_distance)
    tractions_on_body = _tractions_on_body_at_steps(tractions_at_steps, body_number)
    region = _NearContact(
        largest_distance,
        nodes,
        x_of_mesh[nodes],
        y_from_face[nodes],
        tractions_on_body,
        size_effect=None,
    )
    if isinstance(shape, HalfPlane):
        return region
    return replace(region, size_effect=_fit_of_size_effect(nodal_fields, region, half_width))


def _fit_of_size_effect(
    nodal_fields: _NodalFields, region: _NearContact, half_width: float
) -> SizeEffect:
    """Fit of the stress that the finite size of a body adds near the contact: element stress minus
    half-plane stress. All nodes count alike: there are fewer where elements are large, and their
    stress errs more. By weights of area the tension that is added at the edges was 2 % too small on
    coarse meshes.

    The fit takes nodes at which elements are accurate: deeper than 0.15 half-widths, or further
    than 1.2 half-widths from the middle, but not on the face.

    Parameters
    ----------
    nodal_fields
        stress by the elements at all nodes of the body
    region
        nodes of the body near the contact, and the tractions on it
    half_width
        largest contact half-width [length]
    """
    # _ACCURATE_DISTANCE: 1.2 half-widths from the middle
    is_beside = (np.abs(region.x) > _ACCURATE_DISTANCE * half_width) & (region.y < 0)
    # _ACCURATE_DEPTH: 0.15 half-widths below the face
    is_accurate = (region.y < -_ACCURATE_DEPTH * half_width) | is_beside
    x_fitted = region.x[is_accurate]
    y_fitted = region.y[is_accurate]
    stress_by_size = nodal_fields.stress[region.nodes][is_accurate, :3] - _stress_of_tractions(
        region.tractions, x_fitted, y_fitted
    )
    return fitted_size_effect(
        x_fitted, y_fitted, stress_by_size, region.largest_distance, half_width
    )


def _distance_of_fit(shape: Shape, half_width: float) -> float | None:
    """Largest distance from the middle of the contact at which the stress that the finite size of a
    body adds is fitted [length]; None where a support or a side is too near for the fit.

    It is three half-widths of contact, or 0.8 of the way to the nearest support or side where that
    is shorter; too near means below 1.5 half-widths. `half_width` is that of the contact [length].
    """
    # _OUTER_DISTANCE: 3; _SHARE_OF_DISTANCE_TO_SUPPORT: 0.8; _LEAST_OUTER_DISTANCE: 1.5
    largest_distance = min(
        _OUTER_DISTANCE * half_width, _SHARE_OF_DISTANCE_TO_SUPPORT * nearest_end(shape)
    )
    if largest_distance < _LEAST_OUTER_DISTANCE * half_width:
        return None
    return largest_distance


def _tractions_on_body(tractions_on_lower_body: Tractions, body_number: int) -> Tractions:
    """Tractions on the lower (0) or upper (1) body in its own frame, from those on the lower: the
    shear on the upper one has the opposite sign.
    """
    return replace(
        tractions_on_lower_body,
        shear_coefficients=_sign_of_y(body_number) * tractions_on_lower_body.shear_coefficients,
    )


def _tractions_at_steps(
    solution: FiniteElementSolution, steps: Sequence[int]
) -> list[Tractions | None]:
    """Tractions p and q on the lower body at stored steps, as sine series over the contact; None
    where fewer than three nodes touch.
    """
    return [
        tractions_with_uncertainty(_nodal_tractions(solution, step)).tractions for step in steps
    ]


def _tractions_on_body_at_steps(
    tractions_at_steps: Sequence[Tractions | None], body_number: int
) -> list[Tractions | None]:
    """Tractions on the lower (0) or upper (1) body in its own frame at some steps, from those on
    the lower body; None where these are None.
    """
    return [
        None if step_tractions is None else _tractions_on_body(step_tractions, body_number)
        for step_tractions in tractions_at_steps
    ]


def _stress_of_tractions(
    tractions_at_steps: Sequence[Tractions | None], x: Array, y: Array
) -> Array:
    """Stress s_xx, s_yy, s_xy (n, 3, k) of a half-plane y <= 0 at n places under the tractions of k
    steps [stress]; 0 where the tractions are None.
    """
    no_stress = np.zeros((len(x), 3))
    return np.stack(
        [
            no_stress if step_tractions is None else step_tractions.stress(x, y)
            for step_tractions in tractions_at_steps
        ],
        axis=-1,
    )


def _joined_stress(
    nodal_fields: _NodalFields, region_near_contact: _NearContact, material: Elastic
) -> Array:
    """Stress xx, yy, xy, zz at the n nodes of a body at k steps, (n, 4, k). Far from the contact it
    is that of the elements, close to it that of the tractions, blended in between.

    The blending zone is an annulus inside the largest distance of the nodes close to the contact.
    With s the distance from its outer circle over its width, 0 <= s <= 1, the weight of the
    tractions' stress is s^2 (3 - 2 s). At steps without tractions all is that of the elements.

    Parameters
    ----------
    nodal_fields
        its `stress` (n, 4, k) is that by the elements at all nodes
    region_near_contact
        the m nodes close to the contact: numbers (`nodes`), places (`x`, `y`) and their largest
        distance from its middle; the tractions on the body at each step, and the stress that its
        finite size adds (`size_effect`)
    material
        of the body; its Poisson ratio gives s_zz in plane strain
    """
    # Stress s_xx, s_yy, s_xy by the tractions at the nodes close to the contact, (m, 3, k).
    x = region_near_contact.x
    y = region_near_contact.y
    nodes = region_near_contact.nodes
    traction_stress = _stress_of_tractions(region_near_contact.tractions, x, y)
    if region_near_contact.size_effect is not None:
        traction_stress = traction_stress + region_near_contact.size_effect.stress(x, y)

    # Weight of that stress: 1 inside, falling to 0 across the blending zone.
    # _BLENDING_SHARE: width of the blending zone over its outer radius, 0.2
    blending_width = _BLENDING_SHARE * region_near_contact.largest_distance
    s = np.clip((region_near_contact.largest_distance - np.hypot(x, y)) / blending_width, 0.0, 1.0)
    has_tractions = np.array(
        [step_tractions is not None for step_tractions in region_near_contact.tractions]
    )
    weight = (s**2 * (3 - 2 * s))[:, None, None] * has_tractions

    stress = nodal_fields.stress.copy()
    stress[nodes, :3] = (1 - weight) * stress[nodes, :3] + weight * traction_stress
    stress[nodes, 3] = material.poisson_ratio * (stress[nodes, 0] + stress[nodes, 1])
    return stress


def _counter_clockwise_cells(points: Array, cells: Indices) -> Indices:
    """Node numbers of elements, (n_elements, nodes of an element), with those that run clockwise
    reversed: readers of VTU files would give them negative areas.

    `points` are (n, 2) places of the nodes. `cells` are the node numbers of each element: corners,
    then mid-side nodes, then the middle.
    """
    # Twice the signed area of each element's polygon of corners; negative if it runs clockwise.
    n_corners = 3 if cells.shape[1] in (3, 6) else 4
    corners = points[cells[:, :n_corners]]
    next_corners = np.roll(corners, -1, axis=1)
    x = corners[..., 0]
    y = corners[..., 1]
    twice_area = (x * next_corners[..., 1] - next_corners[..., 0] * y).sum(axis=1)
    # _NODES_OF_MIRRORED: order of the nodes of an element that is run through the other way round
    return np.where(twice_area[:, None] < 0, cells[:, _NODES_OF_MIRRORED[cells.shape[1]]], cells)


def _nodal_stress(
    basis: skfem.Basis, displacement: Array, mixed_pressure: Array, condensed_body: CondensedBody
) -> Array:
    """Stress xx, yy, xy, zz at the nodes of a body, (n_nodes, 4), averaged over the elements around
    each node.

    Stress at quadrature points is extrapolated to the nodes of each element, then averaged there
    with the areas as weights.

    Parameters
    ----------
    basis
        finite-element basis of the displacement
    displacement
        (n_dofs,) values of the displacement in this basis [length]
    mixed_pressure
        (n_corners,) part of lambda div(u) that mixed elements have as a further unknown at their
        corners; lambda is Lame's constant, u the displacement [stress]
    condensed_body
        the body, with its material and the order of its elements
    """
    # (4, n_elements, nodes of an element)
    stress_at_element_nodes = (
        _stress_at_quadrature_points(basis, displacement, mixed_pressure, condensed_body)
        @ _matrix_of_extrapolation_to_nodes(basis, condensed_body.order).T
    )

    # Mean over the elements around each node, weighted by their areas.
    element_areas = basis.dx.sum(axis=1)[:, None]
    node_of_entry = cells_of(basis.mesh, condensed_body.order).ravel()
    n_nodes = basis.mesh.p.shape[1]
    # An entry is a node of an element: the node's number, and the area of the element.
    area_of_entry = np.broadcast_to(element_areas, stress_at_element_nodes.shape[1:]).ravel()
    areas_around_nodes = np.bincount(node_of_entry, area_of_entry, n_nodes)
    weighted_sums = [
        np.bincount(node_of_entry, (element_areas * component).ravel(), n_nodes)
        for component in stress_at_element_nodes
    ]
    return np.column_stack([weighted_sum / areas_around_nodes for weighted_sum in weighted_sums])


def _stress_at_quadrature_points(
    basis: skfem.Basis, displacement: Array, mixed_pressure: Array, condensed_body: CondensedBody
) -> Array:
    """Stress xx, yy, xy, zz at the quadrature points of each element of a body, (4, n_elements,
    n_quadrature) [stress], by Hooke's law in plane strain.

    # notation: lam, mu Lame's constants; lam without the part that enters through `mixed_pressure`;
    # s_xx, s_yy, s_xy, s_zz stress

    Parameters
    ----------
    basis
        finite-element basis of the displacement
    displacement
        (n_dofs,) values of the displacement in this basis [length]
    mixed_pressure
        (n_corners,) part of lam div(u) that mixed elements have as a further unknown, r, at their
        corners [stress]
    condensed_body
        the body, with its material and the order of its elements
    """
    lam, _, mu = split_lame(condensed_body.material, condensed_body.order)
    strain = sym_grad(basis.interpolate(displacement))
    mixed_pressure_at_points = basis.with_element(scalar_element(basis.mesh, 1)).interpolate(
        mixed_pressure
    )
    s_zz = lam * (strain[0, 0] + strain[1, 1]) + np.asarray(mixed_pressure_at_points)
    s_xx = s_zz + 2 * mu * strain[0, 0]
    s_yy = s_zz + 2 * mu * strain[1, 1]
    s_xy = 2 * mu * strain[0, 1]
    return np.stack((s_xx, s_yy, s_xy, s_zz))


def _matrix_of_extrapolation_to_nodes(basis: skfem.Basis, order: int) -> Array:
    """Matrix (n_nodes, n_quadrature) that extrapolates values at the quadrature points of an
    element to its nodes, by the polynomial that fits them best in least squares.

    The polynomial is constant for displacements of `order` 1, and linear (bilinear on a
    quadrilateral) of order 2: at the quadrature points stresses of that degree are most accurate.
    `basis` is the finite-element basis of the displacement.

    Source: Zienkiewicz and Zhu (1992), Int. J. Numer. Meth. Engng 33, 1331-1364.
    """
    # Places of an element's nodes in the reference element, (2, n_nodes): corners, then mid-side
    # nodes and the middle where the element has them.
    refdom = basis.mesh.refdom
    corners = np.asarray(refdom.p, dtype=float)
    places_of_nodes = [corners]
    if basis.facet_dofs.size:
        places_of_nodes.append(corners[:, np.array(refdom.facets).T].mean(axis=1))
    if basis.interior_dofs.size:
        places_of_nodes.append(corners.mean(axis=1, keepdims=True))
    n_terms = 1 if order == 1 else refdom.nnodes  # monomials of the polynomial

    def monomials_at(points: Array) -> Array:
        """Monomials 1, x, y, x y at points, (n_points, n_terms)."""
        monomials = [np.ones(points.shape[1]), *points, points[0] * points[1]]
        return np.column_stack(monomials[:n_terms])

    # Least squares with the quadrature weights `basis.W` at the quadrature points `basis.X`.
    root_of_weights = np.sqrt(basis.W)[:, None]
    least_squares = np.linalg.pinv(root_of_weights * monomials_at(basis.X)) * root_of_weights.T
    return np.asarray(monomials_at(np.hstack(places_of_nodes)) @ least_squares)


def _von_mises(stress: Array) -> Array:
    """Von Mises stress (n,) of stress xx, yy, xy, zz (n, 4) [stress]."""
    xx, yy, xy, zz = stress.T
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)
