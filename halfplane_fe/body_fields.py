"""Displacement and stress in both bodies at chosen instants, from the stored interface states.

Stress is that of the elements, averaged at the nodes; next to the contact that of the tractions,
see `face_stress`. Both have the bulk stress in them: uniform in half-planes, that of the elements
in blocks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
import scipy
import skfem
from numpy.typing import ArrayLike
from skfem.helpers import sym_grad

from halfplane_fe.elasticity import (
    CondensedBody,
    cells_of,
    displacement_fields,
    scalar_element,
    split_lame,
    uniform_stretch,
)
from halfplane_fe.face_stress import (
    FEWEST,
    RIM,
    Nodal,
    SizeEffect,
    Tractions,
    fitted_size_effect,
    sampled_tractions,
    tension_of_nodes,
    tractions,
    tractions_with_uncertainty,
)
from halfplane_fe.interface import body_forces
from halfplane_fe.scales import contact_modulus
from halfplane_fe.solution import FiniteElementSolution, KernelSolution
from halfplane_fe.supports import shapes_alike
from scenes import ContactSolution, Elastic, HalfPlane, InputError, Scene, Tabulated
from scenes.array_types import Array, Indices
from scenes.bodies import Shape, face_of

# VTK's order of an element's nodes the other way round, by number of nodes.
_REFLECTED = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3], 4: [0, 3, 2, 1], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}

_BODIES = ("lower", "upper")
# Distance from the middle of the contact over its half-width up to which the stress at nodes is
# that of the tractions,
_OUTER = 3.0
# but no further than this share of the way to the nearest support or side;
_OF_BODY = 0.8
# over the last share of it the elements' takes its place.
_STEP = 0.2
# A body has room for the tractions' stress only if that distance over the half-width is larger.
_LEAST_OUTER = 1.5
# Depth and distance over the half-width from which on elements are good for what the size of the
# body adds.
_BELOW = 0.15
_BESIDE = 1.2
# Pressure of a node over the largest one up to which it is round-off.
_TOUCHES = 1e-9
# Step over the place of a kink of the profile by which its curvature on either side is found.
_STEP_AT_KINK = 1e-3
# Instants at which what the size of a body adds is found for a whole cycle.
_SAMPLED = 12
# The same where the instants of the largest tension are looked for. Of an ellipse a spline through
# six is 2 % of the amplitude off.
_SAMPLED_FOR_SEARCH = 6
# Instants of a cycle among which the largest tension is looked for.
_CANDIDATES = 40
# Of a tension: two ways to sum one series differ by less.
_ROUND_OFF = 1e-9
# Tension by fitted edges over that by nodal values, at most: 0.9 to 1.13 on coarse meshes of the
# library's scenes.
_NODES_TOO_LOW = 1.3
# Angles over the contact at which tractions meet the kernels of a body, which are smooth.
_ANGLES = 128
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
        (2,) x of the left and right edge of contact, by the tractions; NaN out of contact
        [length]
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
    """Both bodies at one instant."""

    time: float
    normal_load: float
    tangential_load: float
    bodies: tuple[BodyFields, BodyFields]


def fields(solution: FiniteElementSolution, instants: Iterable[float]) -> tuple[Snapshot, ...]:
    """Stress and displacement fields in both bodies at the stored steps of a `solution` nearest to
    the given instants.

    Raises
    ------
    InputError
        For an instant outside the solved time; for an answer without meshes.
    """
    if not isinstance(solution, FiniteElementSolution):
        raise InputError("fields: the answer has no meshes, so nothing inside the bodies is known")
    steps = [_step(solution, float(instant)) for instant in instants]
    if not steps:
        return ()
    lower, upper = _fields_of_bodies(solution, steps)
    return tuple(
        Snapshot(
            time=float(solution.time[step]),
            normal_load=float(solution.normal_load[step]),
            tangential_load=float(solution.tangential_load[step]),
            bodies=(fields_of_lower, fields_of_upper),
        )
        for step, fields_of_lower, fields_of_upper in zip(steps, lower, upper, strict=True)
    )


def _fields_of_bodies(
    solution: FiniteElementSolution, steps: Sequence[int]
) -> list[list[BodyFields]]:
    """Fields of the lower and of the upper body of a solution at stored steps: two lists
    (n_steps,).
    """
    tension, tension_uncertainty = edge_tension(solution, steps)
    series_of_steps = [tractions_with_uncertainty(_nodal(solution, step)).series for step in steps]
    bodies = []
    for number, name in enumerate(_BODIES):
        displacement, stress = _displacement_and_stress(solution, steps, series_of_steps, number)
        condensed = solution.condensed[number]
        points = condensed.body.mesh.p.T * [1.0, _sign_of_y(number)]
        cells = _counter_clockwise(points, cells_of(condensed.body.mesh, condensed.order))
        fields_of_steps = []
        for k, (step, tractions_of_step) in enumerate(zip(steps, series_of_steps, strict=True)):
            edges = (np.nan, np.nan) if tractions_of_step is None else tractions_of_step.edges
            fields_of_steps.append(
                BodyFields(
                    name=name,
                    points=points,
                    cells=cells,
                    displacement=displacement[k] + _rigid_motion(solution, number, step, points),
                    stress=stress[k],
                    von_mises=_von_mises(stress[k]),
                    edges=np.array(edges),
                    edge_tension=tension[k, number],
                    edge_tension_uncertainty=tension_uncertainty[k, number],
                )
            )
        bodies.append(fields_of_steps)
    return bodies


def _sign_of_y(number: int) -> float:
    """1 of the lower body (0), -1 of the upper one (1): y of a body's own frame in the common
    one.
    """
    return 1.0 - 2.0 * number


def _displacement_and_stress(
    solution: FiniteElementSolution,
    steps: Sequence[int],
    series: Sequence[Tractions | None],
    number: int,
) -> tuple[Array, Array]:
    """Displacement (n_steps, n, 2) [length], without the rigid motion of the upper body, and stress
    (n_steps, n, 4) of one body at stored steps, in the common frame.

    `series` are the tractions on the lower body at the steps, `number` is 0 of the lower body and 1
    of the upper one.
    """
    material = solution.condensed[number].material
    sign_of_y = _sign_of_y(number)
    bulk_stress = _bulk_stress(solution, steps, number)
    nodal_fields = _nodal_fields(solution, number, steps, bulk_stress)
    near_contact = _near_contact(solution, number, nodal_fields, series)
    stress = (
        nodal_fields.stress
        if near_contact is None
        else _joined_stress(nodal_fields, near_contact, material)
    )
    places = nodal_fields.basis.mesh.p
    displacement = nodal_fields.displacement.reshape(places.shape[1], 2, -1).swapaxes(0, 1)
    if isinstance(getattr(solution.scene.bodies, _BODIES[number]), HalfPlane):
        displacement = displacement + uniform_stretch(material, *places)[..., None] * bulk_stress
        by_bulk_stress = np.array([1.0, 0.0, 0.0, material.poisson_ratio])
        stress = stress + by_bulk_stress[:, None] * bulk_stress
    return (
        displacement.transpose(2, 1, 0) * [1.0, sign_of_y],
        stress.transpose(2, 0, 1) * [1.0, 1.0, sign_of_y, 1.0],
    )


def _rigid_motion(solution: FiniteElementSolution, number: int, step: int, points: Array) -> Array:
    """(n, 2) by tilt, tangential displacement and normal approach of the upper body; 0 of the lower
    one.
    """
    if number == 0:
        return np.zeros_like(points)
    tilt = 0.0 if solution.tilt is None else solution.tilt[step]
    translation = [solution.tangential_displacement[step], -solution.normal_approach[step]]
    return np.asarray(tilt * points[:, ::-1] * [-1.0, 1.0] + translation)


def _step(solution: FiniteElementSolution, instant: float) -> int:
    """Index of the stored step nearest to an instant."""
    start = float(solution.time[0])
    end = float(solution.time[-1])
    if not start - _ROUNDING_OF_TIME <= instant <= end + _ROUNDING_OF_TIME:
        raise InputError(
            f"fields: instant {instant:.6g} lies outside the solved time, {start:.6g} to {end:.6g}"
        )
    return int(np.argmin(np.abs(solution.time - instant)))


def edge_tension(solution: ContactSolution, steps: Sequence[int]) -> tuple[Array, Array]:
    """Stress s_xx of both faces at the edges of contact at stored steps, and its uncertainty
    [stress].

    Its largest value in a cycle is the tension on which lives in fretting fatigue are built: at the
    trailing edge.

    Returns
    -------
    values, uncertainties
        (n_steps, 2, 2) by body (lower, upper) and edge (left, right); 0 out of contact; NaN
        where fewer than three nodes touch, and in a body so thin that what its size adds is not
        known

    Raises
    ------
    InputError
        For bodies of finite size whose meshes are not there: answers that were read back from disk
        have none, nor have kernel solves, of which flat bodies need none.
    """
    if not _has_bodies(solution):
        raise InputError(
            "edge_tension: the answer has no meshes, so what the size of its bodies adds is not"
            " known; solve it again, with meshed bodies"
        )
    tension = _edge_tension(solution, steps)
    of_new_contact = np.array([_of_new_contact(solution, step) for step in steps])
    seen = tension.uncertainties + of_new_contact.reshape(-1, 1, 2)
    return tension.values, np.maximum(seen, tension.of_unseen_slip)


def _has_bodies(solution: ContactSolution) -> bool:
    """Whether it is known what the size of the bodies adds to the stress of their faces: of arcs by
    meshes alone.
    """
    bodies = solution.scene.bodies
    if isinstance(solution, KernelSolution):
        return not bodies.faces_are_true
    return bodies.half_planes or isinstance(solution, FiniteElementSolution)


def _of_new_contact(solution: ContactSolution, step: int) -> Array:
    """(2,) change of the tension at both edges, left and right, by contact that is new since P
    began to grow in full stick, where it is too narrow for the nodes of the rim to show its shear
    [stress].

    Within new contact q/p near the edge is dQ/dP of the time since, behind it what the slip before
    has left. With p = K sqrt(d) a difference c of the two changes s_xx by (4/pi) c K sqrt(w), w the
    width of what is newer: the largest of these counts, of all times since which w is within the
    rim.
    """
    if not step or not _sticks_in_full(solution, step):
        return np.zeros(2)
    p_increments = np.diff(solution.normal_load[: step + 1])
    q_increments = np.diff(solution.tangential_load[: step + 1])
    start = step
    while start > 0 and p_increments[start - 1] > 0 and _sticks_in_full(solution, start):
        start -= 1
    nodal = _nodal(solution, step)
    if start == step or len(nodal.x) <= 2 * RIM:
        return np.zeros(2)
    rim_nodes = [RIM, -1 - RIM]
    pressure = nodal.pressure[rim_nodes]
    rim_depths = np.abs(nodal.x[rim_nodes] - solution.contact_edges[step])
    ratios = q_increments[start:] / p_increments[start:]
    # q/p that was at the edge before each increment since: at the first, what the rim has.
    ratio_before = np.tile(np.append(np.nan, ratios[:-1])[:, None], 2)
    ratio_before[0] = nodal.shear[rim_nodes] / pressure
    widths_of_new = np.abs(solution.contact_edges[step] - solution.contact_edges[start:step])
    change_of_ratio = np.abs(ratios[-1] - ratio_before)
    pressure_at_width = pressure * np.sqrt(widths_of_new / rim_depths)
    changes = np.where(
        widths_of_new < rim_depths, 4 / np.pi * change_of_ratio * pressure_at_width, 0.0
    )
    return np.asarray(changes.max(axis=0))


def _sticks_in_full(solution: ContactSolution, step: int) -> bool:
    """Whether the stick edges are those of contact."""
    return bool(np.array_equal(solution.stick_edges[step], solution.contact_edges[step]))


class _EdgeTension(NamedTuple):
    """Of stored steps, each (n_steps, 2, 2) as of `edge_tension`; `of_unseen_slip` is what slip
    that no node shows yet may change.
    """

    values: Array
    uncertainties: Array
    of_unseen_slip: Array


def _edge_tension(solution: ContactSolution, steps: Sequence[int]) -> _EdgeTension:
    """Stress along each face just outside each edge of contact, at stored steps of a solution, with
    its uncertainty, (n_steps, 2, 2) by body and edge; and what slip that no node shows may change.

    The faces of half-planes by the tractions, plus what the bodies add. NaN where a pressed contact
    has no series of its tractions; 0 where P = 0.
    """
    values = np.zeros((len(steps), 2, 2))
    uncertainties = np.zeros((len(steps), 2, 2))
    of_unseen_slip = np.zeros((len(steps), 2, 2))
    series_of_rows: dict[int, Tractions] = {}
    for row, step in enumerate(steps):
        tractions_of_step = tractions_with_uncertainty(_nodal(solution, step))
        if tractions_of_step.series is not None:
            series_of_rows[row] = tractions_of_step.series
            values[row] = np.outer([1.0, -1.0], tractions_of_step.series.edge_tension())
            uncertainties[row] = tractions_of_step.tension_uncertainty
            of_unseen_slip[row] = tractions_of_step.of_unseen_slip
        elif solution.normal_load[step] > 0:
            values[row] = math.nan
            uncertainties[row] = math.nan
    if series_of_rows:
        rows_with_series = list(series_of_rows)
        tension_by_bodies, uncertainty_by_bodies = _tension_by_bodies(
            solution, [steps[row] for row in rows_with_series], list(series_of_rows.values())
        )
        values[rows_with_series] += tension_by_bodies
        uncertainties[rows_with_series] += uncertainty_by_bodies[:, None]
    return _EdgeTension(values, uncertainties, of_unseen_slip)


def _tension_by_bodies(
    solution: ContactSolution, steps: Sequence[int], series: Sequence[Tractions]
) -> tuple[Array, Array]:
    """What bulk stress and the size of the bodies add to s_xx at both edges of contact [stress].

    Bodies that mirror each other have one size effect, found once.

    Returns
    -------
    values, uncertainties
        (n_steps, 2, 2) by body and edge, and (2,) by body; NaN where it is not known
    """
    bodies = solution.scene.bodies
    material = solution.scene.material
    tension = np.zeros((len(steps), 2, 2))
    uncertainties = np.zeros(2)
    bulk_of_bodies = [_bulk_stress(solution, steps, number) for number in (0, 1)]
    has_bulk_stress = any(bulk_stress.any() for bulk_stress in bulk_of_bodies)
    are_mirrored = bodies.lower == bodies.upper and material.alike and not has_bulk_stress
    size_fit_of_lower: _SizeFit | None = None
    for number, name in enumerate(_BODIES):
        if isinstance(getattr(bodies, name), HalfPlane):
            tension[:, number] = bulk_of_bodies[number][:, None]
            continue
        tractions_on_body = [_on_body(tractions_of_step, number) for tractions_of_step in series]
        if isinstance(solution, KernelSolution):
            size_tension, uncertainty = _tension_by_kernels(solution, number, tractions_on_body)
            tension[:, number] += size_tension
            uncertainties[number] = uncertainty
            continue
        assert isinstance(solution, FiniteElementSolution)  # for the type checker
        if number == 1 and are_mirrored:
            size_fit = size_fit_of_lower
        else:
            size_fit = _size_fit(solution, number, steps, series, bulk_of_bodies[number])
        if size_fit is None:
            tension[:, number] = math.nan
            uncertainties[number] = math.nan
        else:
            # the elements have the bulk stress too
            tension[:, number] = size_fit.tension(tractions_on_body, bulk_of_bodies[number])
            uncertainties[number] = size_fit.uncertainty
        size_fit_of_lower = size_fit
    return tension, uncertainties


def _tension_by_kernels(
    solution: KernelSolution, number: int, tractions_on_body: Sequence[Tractions]
) -> tuple[Array, float]:
    """What the size of a body with a flat face adds to s_xx at both edges of contact, (n_steps, 2),
    and its uncertainty [stress]: E' times the strain by its kernels, for nothing presses there.

    Parameters
    ----------
    number
        0 of the lower body, 1 of the upper one
    tractions_on_body
        the tractions on the body in its own frame, at each step
    """
    name = _BODIES[number]
    kernels = getattr(solution.kernels, name)
    material: Elastic = getattr(solution.scene.material, name)
    modulus = material.young_modulus / (1 - material.poisson_ratio**2)
    angles = math.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
    tension = np.zeros((len(tractions_on_body), 2))
    uncertainty = 0.0
    for k, tractions_of_step in enumerate(tractions_on_body):
        places_in_contact = tractions_of_step.middle - tractions_of_step.half_width * np.cos(angles)
        lengths = tractions_of_step.half_width * np.sin(angles) * math.pi / _ANGLES
        pressing_forces, shear_forces = (
            np.sin(np.outer(angles, np.arange(1, len(sines) + 1))) @ sines * lengths
            for sines in (tractions_of_step.pressure[:_ANGLES], tractions_of_step.shear[:_ANGLES])
        )
        strain, strain_difference = kernels.strain(
            np.array(tractions_of_step.edges), places_in_contact, pressing_forces, shear_forces
        )
        tension[k] = modulus * strain
        uncertainty = max(uncertainty, modulus * float(strain_difference.max()))
    return tension, uncertainty


@dataclass(frozen=True, eq=False)
class _SizeFit:
    """What the size of a body adds, as a linear function of moments of its tractions and of its
    bulk stress.

    Attributes
    ----------
    size_effect
        of the instants that it was found at
    slopes
        (n_causes, n_coefficients) of the size effect
    scale
        (n_causes,) unit of each cause
    uncertainty
        of s_xx at an edge [stress]
    """

    size_effect: SizeEffect
    slopes: Array
    scale: Array
    uncertainty: float

    def tension(self, on_body: Sequence[Tractions], bulk: Array) -> Array:
        """(n_steps, 2) of s_xx at both edges of contact, by the tractions on the body in its own
        frame.
        """
        effect = self.of_causes(_causes(on_body, bulk)[:, : len(self.scale)])
        on_face = np.zeros(2)
        by_size = [
            effect.stress(np.array(of_step.edges), on_face)[:, 0, k]
            for k, of_step in enumerate(on_body)
        ]
        return np.array(by_size)

    def of_causes(self, causes: Array) -> SizeEffect:
        """The size effect by (n_steps, n_causes) causes."""
        return replace(self.size_effect, coefficients=(causes / self.scale @ self.slopes).T)


def _causes(on_body: Sequence[Tractions], bulk: Array) -> Array:
    """(n_steps, 7) moments of the tractions, and the bulk stress."""
    moments = np.array([of_step.moments() for of_step in on_body])
    return np.column_stack([moments, bulk])


def _size_fit(
    solution: FiniteElementSolution,
    number: int,
    steps: Sequence[int],
    series: Sequence[Tractions],
    bulk: Array,
) -> _SizeFit | None:
    """What the size of a body adds to the stress at the face, as a linear function of moments of
    the tractions and of the bulk stress, found at a few of the steps; None where it is not known.

    Parameters
    ----------
    number
        0 of the lower body, 1 of the upper one
    steps
        stored steps of the solution
    series, bulk
        tractions, and bulk stress of the body, at the steps
    """
    evenly_spread = np.linspace(0, len(steps) - 1, _SAMPLED).round().astype(int)
    sampled_numbers = sorted(set(evenly_spread.tolist()))
    sampled_steps = [steps[k] for k in sampled_numbers]
    nodal_fields = _nodal_fields(solution, number, sampled_steps, bulk[sampled_numbers])
    near_contact = _near_contact(
        solution, number, nodal_fields, [series[k] for k in sampled_numbers]
    )
    if near_contact is None or near_contact.size_effect is None:
        return None
    causes = _causes([_on_body(step_tractions, number) for step_tractions in series], bulk)
    # Over P and powers of the half-width: moments that are zero by symmetry must not count as
    # round-off over round-off.
    half_width = max(step_tractions.half_width for step_tractions in series)
    cause_units = np.abs(causes[:, 0]).max() * half_width ** np.array([0, 1, 2, 0, 1, 2])
    if bulk.any():
        cause_units = np.append(cause_units, np.abs(bulk).max())
    causes = causes[sampled_numbers, : len(cause_units)]
    slopes = np.linalg.lstsq(
        causes / cause_units, near_contact.size_effect.coefficients.T, rcond=1e-8
    )[0]
    size_fit = _SizeFit(near_contact.size_effect, slopes, cause_units, uncertainty=0.0)
    origin = np.zeros(1)
    stress_of_fit = size_fit.of_causes(causes).stress(origin, origin)
    missed_stress = near_contact.size_effect.stress(origin, origin) - stress_of_fit
    uncertainty = float(near_contact.size_effect.error.max() + np.abs(missed_stress[:, 0]).max())
    return replace(size_fit, uncertainty=uncertainty)


def stress(
    solution: FiniteElementSolution,
    x: ArrayLike,
    y: ArrayLike,
    instants: ArrayLike,
    *,
    body: Literal["lower", "upper"] = "lower",
) -> Array:
    """Stress next to the contact at any place of one body, from the tractions, at the stored steps
    of a solution nearest to instants.

    Parameters
    ----------
    solution
        by finite elements
    x, y
        (n_points,) places [length]; y points out of the lower body and counts from a face that
        is flattened, so that y <= 0 in the lower body, y >= 0 in the upper one
    instants
        (n_instants,) times
    body
        "lower" or "upper"

    Returns
    -------
    Array
        (n_instants, n_points, 4) s_xx, s_yy, s_xy and s_zz [stress]

    Raises
    ------
    InputError
        For an instant outside the solved time, a place outside the body, or one of a body of finite
        size that is further than three half-widths from the contact, or close to a support or side:
        `fields` has the stress there.
    """
    steps = [
        _step(solution, float(instant))
        for instant in np.atleast_1d(np.asarray(instants, dtype=float))
    ]
    number = _BODIES.index(body)
    sign = _sign_of_y(number)
    x_places, y_places = np.broadcast_arrays(
        np.atleast_1d(np.asarray(x, dtype=float)), np.atleast_1d(sign * np.asarray(y, dtype=float))
    )
    if np.any(y_places > 0):
        raise InputError(
            f"stress: y = {sign * float(y_places.max()):.6g} is outside the {body} body; y points"
            " out of the lower one"
        )
    bulk_stress = _bulk_stress(solution, steps, number)
    series_of_steps = [tractions_with_uncertainty(_nodal(solution, step)).series for step in steps]
    stress = np.zeros((len(steps), len(x_places), 4))
    tractions_on_body = [
        None if step is None else _on_body(step, number) for step in series_of_steps
    ]
    half_plane_stress = _stress_of_tractions(tractions_on_body, x_places, y_places)
    stress[..., :3] = np.moveaxis(half_plane_stress, -1, 0)
    if isinstance(getattr(solution.scene.bodies, body), HalfPlane):
        stress[..., 0] += bulk_stress[:, None]
    elif any(step is not None for step in series_of_steps):
        nodal_fields = _nodal_fields(solution, number, steps, bulk_stress)
        near_contact = _near_contact(solution, number, nodal_fields, series_of_steps)
        size_effect = None if near_contact is None else near_contact.size_effect
        # the limit itself may be missed by rounding
        if size_effect is None or np.any(
            np.hypot(x_places, y_places) > size_effect.length * (1 + 1e-9)
        ):
            raise InputError(
                f"stress: a place in the {body} body is further from the contact than where the"
                " tractions alone give its stress"
            )
        stress[..., :3] += np.moveaxis(size_effect.stress(x_places, y_places), -1, 0)
    stress[..., 2] *= sign
    poisson_ratio = solution.condensed[number].material.poisson_ratio
    stress[..., 3] = poisson_ratio * (stress[..., 0] + stress[..., 1])
    return stress


@dataclass(frozen=True)
class LargestTension:
    """The largest tension s_xx of a cycle at an edge of contact.

    Attributes
    ----------
    value, uncertainty
        of the tension [stress]
    time
        at which it is met
    body
        "lower" or "upper"
    x
        the edge that it is at [length]
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
    """The largest stress along a face just outside an edge of contact in the last cycle of a
    solution, tension positive; None where it is not known, and out of contact.

    Where a load has just turned, elements may still have the tension from before the turn, for the
    new slip zone is narrower than they see. So slip that no node shows does not make the largest
    tension uncertain.
    """
    if not _has_bodies(solution):
        return None
    steps = _steps_of_large_tension(solution)
    if not steps:
        return None
    series_of_steps = [tractions(_nodal(solution, step)) for step in steps]
    tension_by_bodies, body_uncertainties = _tension_by_bodies(solution, steps, series_of_steps)
    tension_by_tractions = [
        np.outer([1.0, -1.0], tractions_of_step.edge_tension())
        for tractions_of_step in series_of_steps
    ]
    values = np.array(tension_by_tractions) + tension_by_bodies
    if np.isnan(values).any():
        return None
    # Of mirrored instants, alike but for round-off, the first counts.
    is_largest = values >= values.max() - _ROUND_OFF * abs(values.max())
    place_of_largest = np.unravel_index(np.argmax(is_largest), values.shape)
    k, body, edge = (int(index) for index in place_of_largest)
    series_uncertainty = tractions_with_uncertainty(_nodal(solution, steps[k])).tension_uncertainty
    edges = series_of_steps[k].edges
    return LargestTension(
        value=float(values[k, body, edge]),
        uncertainty=float(series_uncertainty[edge] + body_uncertainties[body]),
        time=float(solution.time[steps[k]]),
        body=_BODIES[body],
        x=edges[edge],
        edges=edges,
    )


def _steps_of_large_tension(solution: ContactSolution) -> list[int]:
    """The steps of the last cycle among which the largest tension is looked for, in order: those of
    the largest tension by single nodes and what bodies and bulk stress add to it.

    Between half-planes without bulk stress that is all of the tension: there the largest is among
    those that are alike but for round-off. Edges are fitted in the order of the tension by nodal
    values alone, until what is left cannot be among the largest.
    """
    cycle = [int(step) for step in solution.last_cycle]
    nodal_values = {step: _nodal(solution, step) for step in cycle}
    of_nodes = {
        step: tension_of_nodes(nodal)
        for step, nodal in nodal_values.items()
        if len(nodal.x) >= FEWEST
    }
    has_bulk_stress = any(_bulk_stress(solution, cycle, body).any() for body in (0, 1))
    largest_alone = solution.scene.bodies.half_planes and not has_bulk_stress
    n_candidates = 1 if largest_alone else _CANDIDATES
    if len(of_nodes) <= n_candidates:
        return list(of_nodes)
    by_bodies = dict.fromkeys(of_nodes, np.zeros((2, 2)))
    if not largest_alone:
        by_bodies = _between_sampled(solution, {step: nodal_values[step] for step in of_nodes})
    at_most = {
        step: _NODES_TOO_LOW * of_nodes[step] + float(by_bodies[step].max()) for step in of_nodes
    }
    tension: dict[int, float] = {}
    for step in sorted(at_most, key=lambda step: -at_most[step]):
        highest_tensions = sorted(tension.values(), reverse=True)[:n_candidates]
        if len(highest_tensions) == n_candidates and at_most[step] < highest_tensions[-1]:
            break
        at_edges = sampled_tractions(nodal_values[step]).edge_tension()
        of_bodies = np.outer([1.0, -1.0], at_edges) + by_bodies[step]
        tension[step] = float(of_bodies.max())
    highest_tensions = sorted(tension.values(), reverse=True)[:n_candidates]
    # instants that are alike but for round-off are all among them, or none
    least_tension = highest_tensions[-1] * (1 - _ROUND_OFF)
    return [step for step in cycle if tension.get(step, -math.inf) >= least_tension]


def _between_sampled(
    solution: ContactSolution, nodal_values: Mapping[int, Nodal]
) -> dict[int, Array]:
    """About what bodies and bulk stress add to the tension of each step of a solution, (2, 2) by
    body and edge [stress]: found at a few steps, by a cubic spline between them; 0 where it is not
    known.

    `nodal_values` are the tractions at the nodes by the number of the step.
    """
    steps = list(nodal_values)
    evenly_spread = np.linspace(0, len(steps) - 1, _SAMPLED_FOR_SEARCH).round().astype(int)
    sampled_steps = [steps[k] for k in evenly_spread]
    series = [tractions(nodal_values[step]) for step in sampled_steps]
    sampled_tensions, _ = _tension_by_bodies(solution, sampled_steps, series)
    spline = scipy.interpolate.CubicSpline(
        solution.time[sampled_steps], np.nan_to_num(sampled_tensions)
    )
    return dict(zip(steps, spline(solution.time[steps]), strict=True))


def _bulk_stress(solution: ContactSolution, steps: Sequence[int], number: int) -> Array:
    """(n_steps,) bulk stress of the lower (0) or the upper (1) body [stress]."""
    bulk_stress = (solution.bulk_stress_lower, solution.bulk_stress_upper)[number]
    if bulk_stress is None:
        return np.zeros(len(steps))
    return np.asarray(bulk_stress[list(steps)])


def _nodal(solution: ContactSolution, step: int) -> Nodal:
    """Tractions at the closed nodes of a solution at a stored step, with edges, loads and profile
    that their series needs.
    """
    pressure = solution.pressure[step]
    shear = solution.shear[step]
    friction = solution.scene.friction.coefficient
    # A node that just meets or leaves the other face has no pressure but round-off: it counts as
    # open, whatever that is.
    is_closed = pressure > _TOUCHES * np.max(pressure)
    tangential_load = float(solution.tangential_load[step])
    if solution.scene.bodies.faces_are_true and isinstance(solution, FiniteElementSolution):
        tangential_load = float(shear @ solution.weights)  # on curved faces p carries a part of Q
    step_before = max(step - 1, 0)
    rise_of_p = float(solution.normal_load[step] - solution.normal_load[step_before])
    rise_of_q = float(solution.tangential_load[step] - solution.tangential_load[step_before])
    stick_left, stick_right = solution.stick_edges[step].tolist()
    contact_left, contact_right = solution.contact_edges[step].tolist()
    return Nodal(
        x=solution.x[is_closed],
        pressure=pressure[is_closed],
        shear=shear[is_closed],
        stick=(stick_left, stick_right),
        contact=(contact_left, contact_right),
        friction=friction,
        tangential_load=tangential_load,
        # With bulk stress or tilt each edge has a law of its own: taken for unknown, which makes
        # the uncertainty larger, not smaller.
        growing=rise_of_p > 0 and abs(rise_of_q) <= friction * rise_of_p and solution.tilt is None,
        kinks=profile_kinks(solution.scene),
        tabulated=isinstance(solution.scene.profile, Tabulated),
        coupled=not shapes_alike(solution.scene),
    )


def profile_kinks(scene: Scene) -> Array:
    """(k, 2) where the curvature of the gap jumps, and E* times by how much from left to right
    [length, stress/length].
    """
    kinks = []
    for place in scene.profile.kinks:
        step = _STEP_AT_KINK * place
        height_far_left, height_left, height_middle, height_right, height_far_right = (
            scene.profile.height(place + step * np.arange(-2, 3))
        )
        second_difference_left = height_far_left - 2 * height_left + height_middle
        second_difference_right = height_middle - 2 * height_right + height_far_right
        curvature_jump = (second_difference_right - second_difference_left) / step**2
        kinks += [(place, curvature_jump), (-place, -curvature_jump)]
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    return np.array(kinks).reshape(-1, 2) * [1.0, modulus]


@dataclass(frozen=True, eq=False)
class _NodalFields:
    """What the elements of a body give at its n nodes at k stored steps, in its own frame.

    The bulk stress of a block is in both; that of a half-plane is not.

    Attributes
    ----------
    basis
        of the displacement
    displacement
        (n_dofs, k) [length]
    stress
        (n, 4, k) xx, yy, xy, zz [stress]
    areas
        (n,) that each node stands for
    """

    basis: skfem.Basis
    displacement: Array
    stress: Array
    areas: Array


def _nodal_fields(
    solution: FiniteElementSolution, body_number: int, steps: Sequence[int], bulk_stress: Array
) -> _NodalFields:
    """Displacements and nodal stresses of the lower (0) or upper (1) body at stored steps, with its
    bulk stress (k,) at each step.
    """
    condensed = solution.condensed[body_number]
    states = [solution.states[step] for step in steps]
    pressure = np.stack([state.pressure for state in states], axis=1) * solution.scales.load
    shear = np.stack([state.shear for state in states], axis=1) * solution.scales.load
    forces = body_forces(*solution.condensed, pressure, shear)[_BODIES[body_number]]
    basis, displacements, tensions = displacement_fields(
        condensed, forces, solution.scene.profile.datum_length, bulk_stress
    )
    stresses = []
    for displacement, tension in zip(displacements.T, tensions.T, strict=True):
        stress, areas = _nodal_stress(basis, displacement, tension, condensed)
        stresses.append(stress)
    return _NodalFields(basis, displacements, np.stack(stresses, axis=-1), areas)


@dataclass(frozen=True, eq=False)
class _NearContact:
    """The part of a body next to the contact, where its stress is that of the tractions.

    Attributes
    ----------
    limit
        distance from the middle of the contact up to which it goes [length]
    nodes
        (m,) in it
    x, y
        (m,) their places, the face flattened [length]
    series
        (k,) tractions on this body, in its own frame; None out of contact
    size_effect
        what the size of the body adds; None of a half-plane
    """

    limit: float
    nodes: Indices
    x: Array
    y: Array
    series: Sequence[Tractions | None]
    size_effect: SizeEffect | None


def _near_contact(
    solution: FiniteElementSolution,
    number: int,
    nodal_fields: _NodalFields,
    series: Sequence[Tractions | None],
) -> _NearContact | None:
    """The nodes of a body next to the contact, the tractions on it and what its size adds to the
    stress there; None where nothing touches, and where the body is so thin that all of it is next
    to the contact.

    Parameters
    ----------
    number
        0 of the lower body, 1 of the upper one
    nodal_fields
        stress and displacement at its nodes by the elements
    series
        (k,) the tractions on the lower body at the steps, None without contact
    """
    shape = getattr(solution.scene.bodies, _BODIES[number])
    half_widths = [
        tractions_of_step.half_width
        for tractions_of_step in series
        if tractions_of_step is not None
    ]
    if not half_widths:
        return None
    half_width = max(half_widths)
    largest_distance = min(_OUTER * half_width, _OF_BODY * _room(shape))
    if largest_distance < _LEAST_OUTER * half_width:
        return None
    x, y = nodal_fields.basis.mesh.p
    y = np.minimum(y + face_of(shape, solution.scene.profile).depth(np.abs(x)), 0.0)
    nodes = np.flatnonzero(np.hypot(x, y) < largest_distance)
    x = x[nodes]
    y = y[nodes]
    tractions_on_body = [
        None if tractions_of_step is None else _on_body(tractions_of_step, number)
        for tractions_of_step in series
    ]
    size_effect = None
    if not isinstance(shape, HalfPlane):
        is_beside = (np.abs(x) > _BESIDE * half_width) & (y < 0)
        is_accurate = (y < -_BELOW * half_width) | is_beside
        x_fitted = x[is_accurate]
        y_fitted = y[is_accurate]
        stress_beyond = nodal_fields.stress[nodes][is_accurate, :3] - _stress_of_tractions(
            tractions_on_body, x_fitted, y_fitted
        )
        areas = nodal_fields.areas[nodes][is_accurate]
        size_effect = fitted_size_effect(
            x_fitted, y_fitted, stress_beyond, areas, largest_distance, half_width
        )
    return _NearContact(largest_distance, nodes, x, y, tractions_on_body, size_effect)


def _on_body(tractions_on_lower: Tractions, number: int) -> Tractions:
    """Tractions on the lower body as the body with this number has them in its own frame."""
    return replace(tractions_on_lower, shear=_sign_of_y(number) * tractions_on_lower.shear)


def _stress_of_tractions(series: Sequence[Tractions | None], x: Array, y: Array) -> Array:
    """(n, 3, k) s_xx, s_yy, s_xy of a half-plane y <= 0 at (n,) places; 0 out of contact."""
    none = np.zeros((len(x), 3))
    return np.stack([none if step is None else step.stress(x, y) for step in series], axis=-1)


def _joined_stress(
    nodal_fields: _NodalFields, near_contact: _NearContact, material: Elastic
) -> Array:
    """Stress xx, yy, xy, zz at the nodes of a body, (n, 4, k): beside the contact that by the
    tractions and by the size of the body; further away that of the elements; a smooth step leads
    from the one to the other.

    `nodal_fields` is stress by the elements, `near_contact` the nodes beside the contact with the
    tractions, `material` that of the body.
    """
    stress = nodal_fields.stress.copy()
    traction_stress = _stress_of_tractions(near_contact.series, near_contact.x, near_contact.y)
    if near_contact.size_effect is not None:
        traction_stress = traction_stress + near_contact.size_effect.stress(
            near_contact.x, near_contact.y
        )
    distance_to_limit = (near_contact.limit - np.hypot(near_contact.x, near_contact.y)) / (
        _STEP * near_contact.limit
    )
    share_of_tractions = np.clip(distance_to_limit, 0.0, 1.0)
    share_of_tractions = (share_of_tractions**2 * (3 - 2 * share_of_tractions))[:, None, None]
    nodes = near_contact.nodes
    stress[nodes, :3] = (1 - share_of_tractions) * stress[
        nodes, :3
    ] + share_of_tractions * traction_stress
    stress[nodes, 3] = material.poisson_ratio * (stress[nodes, 0] + stress[nodes, 1])
    return stress


def _room(shape: Shape) -> float:
    """Distance from the middle of the face to the nearest support or side of a body [length]."""
    return min(shape.face_half_width, shape.least_depth)


def _counter_clockwise(points: Array, cells: Indices) -> Indices:
    """`cells` with those that go round clockwise reversed: readers of VTU would give them negative
    areas.
    """
    n_corners = 3 if cells.shape[1] in (3, 6) else 4
    corners = points[cells[:, :n_corners]]
    next_corners = np.roll(corners, -1, axis=1)
    x = corners[..., 0]
    y = corners[..., 1]
    twice_area = (x * next_corners[..., 1] - next_corners[..., 0] * y).sum(axis=1)
    return np.where(twice_area[:, None] < 0, cells[:, _REFLECTED[cells.shape[1]]], cells)


def _nodal_stress(
    basis: skfem.Basis, displacement: Array, tension: Array, condensed: CondensedBody
) -> tuple[Array, Array]:
    """Stress xx, yy, xy, zz at the nodes, (n_nodes, 4), and the sum of the areas of the elements
    around each node, (n_nodes,): element stresses are carried to each node and averaged there with
    these areas as weights.

    Parameters
    ----------
    basis
        of the displacement
    displacement
        values of the displacement in this basis [length]
    tension
        part of lam div(u) that is found beside the displacement, at the corners [stress]
    condensed
        the body, with its material and the order of its elements
    """
    # notation: lam, mu are Lame's constants, the part of lam that enters through `tension` left out
    lam, _, mu = split_lame(condensed.material, condensed.order)
    strain = sym_grad(basis.interpolate(displacement))
    tension_at_points = basis.with_element(scalar_element(basis.mesh, 1)).interpolate(tension)
    s_zz = lam * (strain[0, 0] + strain[1, 1]) + np.asarray(tension_at_points)
    s_xx = s_zz + 2 * mu * strain[0, 0]
    s_yy = s_zz + 2 * mu * strain[1, 1]
    s_xy = 2 * mu * strain[0, 1]
    stress_at_element_nodes = (
        np.stack((s_xx, s_yy, s_xy, s_zz)) @ _to_nodes(basis, condensed.order).T
    )
    element_areas = basis.dx.sum(axis=1)[:, None]
    cells = cells_of(basis.mesh, condensed.order).ravel()
    n_nodes = basis.mesh.p.shape[1]
    areas_of_nodes = np.broadcast_to(element_areas, stress_at_element_nodes.shape[1:]).ravel()
    areas = np.bincount(cells, areas_of_nodes, n_nodes)
    weighted_sums = [
        np.bincount(cells, (element_areas * component).ravel(), n_nodes)
        for component in stress_at_element_nodes
    ]
    return np.column_stack([weighted_sum / areas for weighted_sum in weighted_sums]), np.asarray(
        areas, dtype=float
    )


def _to_nodes(basis: skfem.Basis, order: int) -> Array:
    """(n_nodes, n_quadrature) matrix of one element, from values at its quadrature points to values
    at its nodes, by the polynomial nearest to the former.

    The polynomial has a degree less than the displacement, where stresses are most accurate:
    constant, or linear (bilinear on a quadrilateral). Source: Zienkiewicz and Zhu (1992), Int. J.
    Numer. Meth. Engng 33, 1331-1364.
    """
    refdom = basis.mesh.refdom
    corners = np.asarray(refdom.p, dtype=float)
    groups_of_nodes = [corners]
    if basis.facet_dofs.size:
        groups_of_nodes.append(corners[:, np.array(refdom.facets).T].mean(axis=1))
    if basis.interior_dofs.size:
        groups_of_nodes.append(corners.mean(axis=1, keepdims=True))
    n_terms = 1 if order == 1 else refdom.nnodes

    def polynomial(points: Array) -> Array:
        """(n_points, n_terms) of 1, x, y, x y."""
        monomials = [np.ones(points.shape[1]), *points, points[0] * points[1]]
        return np.column_stack(monomials[:n_terms])

    root_of_weights = np.sqrt(basis.W)[:, None]
    least_squares = np.linalg.pinv(root_of_weights * polynomial(basis.X)) * root_of_weights.T
    return np.asarray(polynomial(np.hstack(groups_of_nodes)) @ least_squares)


def _von_mises(stress: Array) -> Array:
    xx, yy, xy, zz = stress.T
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)
