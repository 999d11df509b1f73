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
_SHARE_OF_ROOM = 0.8
# over the last share of it the elements' takes its place.
_BLENDING_SHARE = 0.2
# A body has room for the tractions' stress only if that distance over the half-width is larger.
_LEAST_OUTER_DISTANCE = 1.5
# Depth and distance over the half-width from which on elements are good for what the size of the
# body adds.
_ACCURATE_DEPTH = 0.15
_ACCURATE_DISTANCE = 1.2
# Pressure of a node over the largest one up to which it is round-off.
_NEGLIGIBLE_PRESSURE = 1e-9
# Step over the place of a kink of the profile by which its curvature on either side is found.
_STEP_AT_KINK = 1e-3
# Instants at which what the size of a body adds is found for a whole cycle.
_N_SAMPLED_STEPS = 12
# The same where the instants of the largest tension are looked for. Of an ellipse a spline through
# six is 2 % of the amplitude off.
_N_STEPS_OF_SEARCH = 6
# Instants of a cycle among which the largest tension is looked for.
_N_CANDIDATES = 40
# Of a tension: two ways to sum one series differ by less.
_ROUND_OFF = 1e-9
# Tension by fitted edges over that by nodal values, at most: 0.9 to 1.13 on coarse meshes of the
# library's scenes.
_LARGEST_RATIO_TO_NODAL = 1.3
# Share of what new contact may change that it does change where one of its nodes shows the shear:
# 0.15 at most on seed 250 of benchmarks/covered.py values, default preset.
_SHOWN_BY_A_NODE = 0.25
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
    """Nodal stress and displacement of the lower and of the upper body of a solution: two lists of
    fields, (n_steps,) each, in the common frame (y out of the lower body).

    `steps` are indices of stored instants.
    """
    tension, tension_uncertainty = edge_tension(solution, steps)
    series_of_steps = [tractions_with_uncertainty(_nodal(solution, step)).series for step in steps]
    bodies = []
    for number, name in enumerate(_BODY_NAMES):
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
    """Displacement (n_steps, n, 2) [length] and stress xx, yy, xy, zz (n_steps, n, 4) at the n
    nodes of one body, in the common frame (y out of the lower body).

    Far from the contact the stress is that of the elements, next to it that of the tractions on a
    half-plane. The rigid motion of the upper body is left out.

    Parameters
    ----------
    steps
        indices of stored instants
    series
        tractions on the lower body at each step, as series; None out of contact
    number
        0 of the lower body, 1 of the upper one
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
    # The elements of other bodies have the bulk stress in them.
    if isinstance(getattr(solution.scene.bodies, _BODY_NAMES[number]), HalfPlane):
        displacement = displacement + uniform_stretch(material, *places)[..., None] * bulk_stress
        by_bulk_stress = np.array([1.0, 0.0, 0.0, material.poisson_ratio])
        stress = stress + by_bulk_stress[:, None] * bulk_stress
    return (
        displacement.transpose(2, 1, 0) * [1.0, sign_of_y],
        stress.transpose(2, 0, 1) * [1.0, 1.0, sign_of_y, 1.0],
    )


def _rigid_motion(solution: FiniteElementSolution, number: int, step: int, points: Array) -> Array:
    """Displacement (n, 2) of points of the upper body as it moves rigidly, by tilt, tangential
    displacement and normal approach [length]; 0 of the lower body (`number` 0).
    """
    if number == 0:
        return np.zeros_like(points)
    tilt = 0.0 if solution.tilt is None else solution.tilt[step]
    translation = [solution.tangential_displacement[step], -solution.normal_approach[step]]
    return np.asarray(tilt * points[:, ::-1] * [-1.0, 1.0] + translation)


def _step(solution: FiniteElementSolution, instant: float) -> int:
    """Index of the stored step of a solution whose time is nearest to an instant; InputError for an
    instant outside the solved time.
    """
    start = float(solution.time[0])
    end = float(solution.time[-1])
    if not start - _ROUNDING_OF_TIME <= instant <= end + _ROUNDING_OF_TIME:
        raise InputError(
            f"fields: instant {instant:.6g} lies outside the solved time, {start:.6g} to {end:.6g}"
        )
    return int(np.argmin(np.abs(solution.time - instant)))


def edge_tension(solution: ContactSolution, steps: Sequence[int]) -> tuple[Array, Array]:
    """Stress s_xx along both faces at the edges of contact, tension positive, and its uncertainty
    [stress].

    Its largest value in a cycle, at the trailing edge, is the tension on which lives in fretting
    fatigue are built.

    Parameters
    ----------
    solution
        by finite elements or by kernels
    steps
        (n_steps,) indices of its stored instants

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
    # A narrow strip of new contact, or of slip, may lie between the nodes at an edge.
    change_by_new_contact = np.array([_of_new_contact(solution, step) for step in steps])
    uncertainties = tension.uncertainties + change_by_new_contact.reshape(-1, 1, 2)
    return tension.values, np.maximum(uncertainties, tension.of_unseen_slip)


def _has_bodies(solution: ContactSolution) -> bool:
    """Whether it is known what the size of the bodies adds to the stress of their faces: of arcs by
    meshes alone.
    """
    bodies = solution.scene.bodies
    if isinstance(solution, KernelSolution):
        return not bodies.faces_are_true
    return bodies.half_planes or isinstance(solution, FiniteElementSolution)


def _of_new_contact(solution: ContactSolution, step: int) -> Array:
    """Possible error of the tension at the left and right edge, (2,) [stress], where the contact
    has just grown by a strip so narrow that no node shows the shear in it.

    While P grows in full stick, q/p in the new strip is dQ/dP, while behind it q/p is what earlier
    slip has left. With p = K sqrt(d) near the edge, a jump c of q/p at the depth w changes s_xx by
    (4/pi) c K sqrt(w). The largest of these counts, of all instants since which w is still less
    than the depth of the outermost nodes (the rim); a quarter of it where a node lies in the strip.

    # notation: d distance from the edge, K constant of the pressure there, w width of the strip
    """
    if not step or not _sticks_in_full(solution, step):
        return np.zeros(2)
    p_increments = np.diff(solution.normal_load[: step + 1])
    q_increments = np.diff(solution.tangential_load[: step + 1])
    start = step  # the stored step at which P began to grow in full stick
    while start > 0 and p_increments[start - 1] > 0 and _sticks_in_full(solution, start):
        start -= 1
    nodal = _nodal(solution, step)
    if start == step or len(nodal.x) <= 2 * RIM:
        return np.zeros(2)
    rim_nodes = [RIM, -1 - RIM]
    pressure = nodal.pressure[rim_nodes]
    rim_depths = np.abs(nodal.x[rim_nodes] - solution.contact_edges[step])
    q_over_p = q_increments[start:] / p_increments[start:]  # in the strip of each increment
    # q/p that was at the edge before each increment: before the first, that of the rim's node.
    ratio_before = np.tile(np.append(np.nan, q_over_p[:-1])[:, None], 2)
    ratio_before[0] = nodal.shear[rim_nodes] / pressure
    strip_widths = np.abs(solution.contact_edges[step] - solution.contact_edges[start:step])
    jump_of_ratio = np.abs(q_over_p[-1] - ratio_before)
    pressure_at_width = pressure * np.sqrt(strip_widths / rim_depths)
    depths_of_outermost = np.abs(nodal.x[[0, -1]] - solution.contact_edges[step])
    share_unseen = np.where(strip_widths < depths_of_outermost, 1.0, _SHOWN_BY_A_NODE)
    share_unseen[strip_widths >= rim_depths] = 0.0
    changes = share_unseen * 4 / np.pi * jump_of_ratio * pressure_at_width
    return np.asarray(changes.max(axis=0))


def _sticks_in_full(solution: ContactSolution, step: int) -> bool:
    """Whether the stick edges are those of contact."""
    return bool(np.array_equal(solution.stick_edges[step], solution.contact_edges[step]))


class _EdgeTension(NamedTuple):
    """Stress s_xx along the faces at the edges of contact, its uncertainty, and what slip in a zone
    too narrow for the nodes may change: each (n_steps, 2, 2) by body and edge [stress].
    """

    values: Array
    uncertainties: Array
    of_unseen_slip: Array


def _edge_tension(solution: ContactSolution, steps: Sequence[int]) -> _EdgeTension:
    """Stress s_xx along each face just outside each edge of contact, with its uncertainty and what
    slip in a zone too narrow for the nodes may change.

    It is the tension that the tractions cause in a half-plane, opposite in the two bodies, plus
    what bulk stress and the size of each body add. Arrays are (n_steps, 2, 2) by body and edge: NaN
    where too few nodes touch to fit the tractions by a series, 0 where P = 0.

    Parameters
    ----------
    steps
        (n_steps,) indices of stored instants
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
    """Stress s_xx at both edges of contact that bulk stress and the finite size of the bodies add
    to that of half-planes.

    Two bodies that mirror each other have one effect of size, which is computed once.

    Parameters
    ----------
    steps
        (n_steps,) indices of stored instants
    series
        tractions on the lower body at each step, as series

    Returns
    -------
    values, uncertainties
        (n_steps, 2, 2) by body and edge, and (2,) by body [stress]; NaN where it is not known
    """
    bodies = solution.scene.bodies
    material = solution.scene.material
    tension = np.zeros((len(steps), 2, 2))
    uncertainties = np.zeros(2)
    bulk_of_bodies = [_bulk_stress(solution, steps, number) for number in (0, 1)]
    has_bulk_stress = any(bulk_stress.any() for bulk_stress in bulk_of_bodies)
    are_mirrored = bodies.lower == bodies.upper and material.alike and not has_bulk_stress
    size_fit_of_lower: _SizeFit | None = None
    for number, name in enumerate(_BODY_NAMES):
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
    """Stress s_xx at both edges of contact that the finite size of a flat-faced body adds to that
    of a half-plane, (n_steps, 2), and its uncertainty [stress].

    It is E/(1 - nu^2) times the strain along the face, since no pressure acts beside the contact.
    The strain is the body's response to the nodal forces (its kernels), integrated by Gauss-
    Chebyshev points over the contact.

    Parameters
    ----------
    number
        0 of the lower body, 1 of the upper one
    tractions_on_body
        tractions on the body in its own frame at each step, as sine series over the contact
    """
    name = _BODY_NAMES[number]
    kernels = getattr(solution.kernels, name)
    material: Elastic = getattr(solution.scene.material, name)
    modulus = material.young_modulus / (1 - material.poisson_ratio**2)
    angles = math.pi * (np.arange(_N_ANGLES) + 0.5) / _N_ANGLES
    tension = np.zeros((len(tractions_on_body), 2))
    uncertainty = 0.0
    for k, tractions_of_step in enumerate(tractions_on_body):
        places_in_contact = tractions_of_step.middle - tractions_of_step.half_width * np.cos(angles)
        lengths = tractions_of_step.half_width * np.sin(angles) * math.pi / _N_ANGLES
        pressing_forces, shear_forces = (
            np.sin(np.outer(angles, np.arange(1, len(sines) + 1))) @ sines * lengths
            for sines in (
                tractions_of_step.pressure[:_N_ANGLES],
                tractions_of_step.shear[:_N_ANGLES],
            )
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
    """Least-squares fit of what the finite size of a body adds to the stress beside the contact:
    linear in its causes, which are moments of the tractions and the bulk stress.

    The stress of the elements minus that of a half-plane is found at a dozen steps, spread evenly;
    the fit gives it at all others. None where the body is too thin for it.

    Parameters
    ----------
    number
        0 of the lower body, 1 of the upper one
    steps
        (n_steps,) indices of stored instants
    series, bulk
        tractions on the lower body as series, and bulk stress of this body, at the steps
    """
    evenly_spread = np.linspace(0, len(steps) - 1, _N_SAMPLED_STEPS).round().astype(int)
    sampled_rows = sorted(set(evenly_spread.tolist()))
    sampled_steps = [steps[k] for k in sampled_rows]
    nodal_fields = _nodal_fields(solution, number, sampled_steps, bulk[sampled_rows])
    near_contact = _near_contact(solution, number, nodal_fields, [series[k] for k in sampled_rows])
    if near_contact is None or near_contact.size_effect is None:
        return None
    causes = _causes([_on_body(step_tractions, number) for step_tractions in series], bulk)
    # Over P and powers of the half-width: moments that are zero by symmetry must not count as
    # round-off over round-off.
    half_width = max(step_tractions.half_width for step_tractions in series)
    cause_units = np.abs(causes[:, 0]).max() * half_width ** np.array([0, 1, 2, 0, 1, 2])
    if bulk.any():
        cause_units = np.append(cause_units, np.abs(bulk).max())
    causes = causes[sampled_rows, : len(cause_units)]
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
        (n_points,) places [length]; y points out of the lower body and counts from the face as if
        that were flat: y <= 0 in the lower body, y >= 0 in the upper one
    instants
        (n_instants,) times; the stored step nearest to each is taken
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
    instant_times = np.atleast_1d(np.asarray(instants, dtype=float))
    steps = [_step(solution, float(instant)) for instant in instant_times]
    number = _BODY_NAMES.index(body)
    sign_of_y = _sign_of_y(number)
    x_places, y_places = np.broadcast_arrays(
        np.atleast_1d(np.asarray(x, dtype=float)),
        np.atleast_1d(sign_of_y * np.asarray(y, dtype=float)),
    )
    if np.any(y_places > 0):
        raise InputError(
            f"stress: y = {sign_of_y * float(y_places.max()):.6g} is outside the {body} body; y"
            " points out of the lower one"
        )
    bulk_stress = _bulk_stress(solution, steps, number)
    series_of_steps = [tractions_with_uncertainty(_nodal(solution, step)).series for step in steps]
    tractions_on_body = [
        None if series is None else _on_body(series, number) for series in series_of_steps
    ]
    stress = np.zeros((len(steps), len(x_places), 4))
    half_plane_stress = _stress_of_tractions(tractions_on_body, x_places, y_places)
    stress[..., :3] = np.moveaxis(half_plane_stress, -1, 0)
    if isinstance(getattr(solution.scene.bodies, body), HalfPlane):
        stress[..., 0] += bulk_stress[:, None]
    elif any(series is not None for series in series_of_steps):
        nodal_fields = _nodal_fields(solution, number, steps, bulk_stress)
        near_contact = _near_contact(solution, number, nodal_fields, series_of_steps)
        size_effect = None if near_contact is None else near_contact.size_effect
        distances = np.hypot(x_places, y_places)
        # A place at the limit itself may miss it by rounding.
        if size_effect is None or np.any(distances > size_effect.length * (1 + 1e-9)):
            raise InputError(
                f"stress: a place in the {body} body is further from the contact than where the"
                " tractions alone give its stress"
            )
        stress[..., :3] += np.moveaxis(size_effect.stress(x_places, y_places), -1, 0)
    stress[..., 2] *= sign_of_y  # s_xy from the body's own frame to the common one
    poisson_ratio = solution.condensed[number].material.poisson_ratio
    stress[..., 3] = poisson_ratio * (stress[..., 0] + stress[..., 1])  # plane strain
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
    """The largest tension s_xx of the last cycle of a solution, along either face just outside an
    edge of contact, with its place, time and uncertainty.

    None out of contact, and where it is not known what the size of a body adds. Just after a load
    has turned, the new slip zone is narrower than an element, so that the stress is still that from
    before the turn. The largest tension is met before a turn: such slip leaves it certain.
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
        body=_BODY_NAMES[body],
        x=edges[edge],
        edges=edges,
    )


def _steps_of_large_tension(solution: ContactSolution) -> list[int]:
    """Candidates for the instant of the largest edge tension: steps of the last cycle, in order of
    time, at which an estimate of it is highest.

    The estimate is the tension by tractions that are fitted at few points, plus what bodies and
    bulk stress add, interpolated in time. Fits cost most, so they are made in the order of a
    cheaper bound, by nodal values alone. They end when no step left can be among the highest.

    Between half-planes without bulk stress the estimate is exact, and one candidate is enough.
    """
    cycle = [int(step) for step in solution.last_cycle]
    nodal_values = {step: _nodal(solution, step) for step in cycle}
    tension_by_nodes = {
        step: tension_of_nodes(nodal)
        for step, nodal in nodal_values.items()
        if len(nodal.x) >= FEWEST
    }
    has_bulk_stress = any(_bulk_stress(solution, cycle, body).any() for body in (0, 1))
    is_exact = solution.scene.bodies.half_planes and not has_bulk_stress
    n_candidates = 1 if is_exact else _N_CANDIDATES
    if len(tension_by_nodes) <= n_candidates:
        return list(tension_by_nodes)
    tension_by_bodies = dict.fromkeys(tension_by_nodes, np.zeros((2, 2)))
    if not is_exact:
        tension_by_bodies = _between_sampled(
            solution, {step: nodal_values[step] for step in tension_by_nodes}
        )
    upper_bounds = {
        step: _LARGEST_RATIO_TO_NODAL * tension + float(tension_by_bodies[step].max())
        for step, tension in tension_by_nodes.items()
    }
    estimates: dict[int, float] = {}
    for step in sorted(upper_bounds, key=lambda step: -upper_bounds[step]):
        highest_estimates = sorted(estimates.values(), reverse=True)[:n_candidates]
        if len(highest_estimates) == n_candidates and upper_bounds[step] < highest_estimates[-1]:
            break
        tension_at_edges = sampled_tractions(nodal_values[step]).edge_tension()
        tension_of_bodies = np.outer([1.0, -1.0], tension_at_edges) + tension_by_bodies[step]
        estimates[step] = float(tension_of_bodies.max())
    highest_estimates = sorted(estimates.values(), reverse=True)[:n_candidates]
    # Instants that are alike but for round-off are all candidates, or none.
    least_estimate = highest_estimates[-1] * (1 - _ROUND_OFF)
    return [step for step in cycle if estimates.get(step, -math.inf) >= least_estimate]


def _between_sampled(
    solution: ContactSolution, nodal_values: Mapping[int, Nodal]
) -> dict[int, Array]:
    """Estimate of what bulk stress and the size of the bodies add to the edge tension at each step:
    step -> (2, 2) by body and edge [stress].

    It is computed at six steps and interpolated in time by a cubic spline; 0 where it is not known.
    `nodal_values` maps the index of a stored step to the tractions at its nodes.
    """
    steps = list(nodal_values)
    evenly_spread = np.linspace(0, len(steps) - 1, _N_STEPS_OF_SEARCH).round().astype(int)
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
    """Pressure and shear at the touching nodes of a solution at a stored step, with all that a fit
    of them by a series needs: edges of stick and contact, friction, Q, kinks of the profile.
    """
    pressure = solution.pressure[step]
    shear = solution.shear[step]
    friction = solution.scene.friction.coefficient
    # A node that just meets or leaves the other face has no pressure but round-off: it counts as
    # open, whatever that is.
    is_closed = pressure > _NEGLIGIBLE_PRESSURE * np.max(pressure)
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
        unlike=not solution.scene.material.alike,
    )


def profile_kinks(scene: Scene) -> Array:
    """Places where the curvature of the profile jumps, and E* times the jump: (k, 2), left side
    subtracted from right [length, stress/length].

    Curvatures on either side are second differences of the height h with a step of a thousandth of
    the place. Each kink at x > 0 has its mirror image at -x.
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
    """Displacement and stress at the nodes of one body by its elements, at k stored steps, in the
    body's own frame.

    Parameters
    ----------
    body_number
        0 of the lower body, 1 of the upper one
    steps
        (k,) indices of stored instants
    bulk_stress
        (k,) of this body at the steps [stress]
    """
    condensed = solution.condensed[body_number]
    states = [solution.states[step] for step in steps]
    pressure = np.stack([state.pressure for state in states], axis=1) * solution.scales.load
    shear = np.stack([state.shear for state in states], axis=1) * solution.scales.load
    forces = body_forces(*solution.condensed, pressure, shear)[_BODY_NAMES[body_number]]
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
    """The nodes of a body within three half-widths of the contact, the tractions on the body, and a
    fit of what its finite size adds to the stress at these nodes.

    There stress follows from the tractions more accurately than from the elements. The fit rests on
    nodes deep enough, or far enough beside the contact, for the elements to be accurate. None where
    nothing touches, and where a support or a side is too near.

    Parameters
    ----------
    number
        0 of the lower body, 1 of the upper one
    nodal_fields
        stress and displacement at its nodes by the elements, at k steps
    series
        (k,) tractions on the lower body at the steps, None without contact
    """
    shape = getattr(solution.scene.bodies, _BODY_NAMES[number])
    half_widths = [
        tractions_of_step.half_width
        for tractions_of_step in series
        if tractions_of_step is not None
    ]
    if not half_widths:
        return None
    half_width = max(half_widths)
    largest_distance = min(_OUTER_DISTANCE * half_width, _SHARE_OF_ROOM * _room(shape))
    if largest_distance < _LEAST_OUTER_DISTANCE * half_width:
        return None
    x, y = nodal_fields.basis.mesh.p
    # Depth below the curved face, as if that were flat.
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
        is_beside = (np.abs(x) > _ACCURATE_DISTANCE * half_width) & (y < 0)
        is_accurate = (y < -_ACCURATE_DEPTH * half_width) | is_beside
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
    """Stress xx, yy, xy, zz at the n nodes of a body at k steps, (n, 4, k): that of the elements
    far from the contact, that of the tractions close to it, blended in between.

    With s the distance to the limit of the close part over the width of the blending zone, clipped
    to 0 <= s <= 1, the weight of the tractions' stress is s^2 (3 - 2 s).

    Parameters
    ----------
    nodal_fields
        stress by the elements at all nodes
    near_contact
        the nodes close to the contact, the tractions on the body, and the effect of its size
    material
        of the body; its Poisson ratio gives s_zz in plane strain
    """
    x = near_contact.x
    y = near_contact.y
    nodes = near_contact.nodes
    traction_stress = _stress_of_tractions(near_contact.series, x, y)
    if near_contact.size_effect is not None:
        traction_stress = traction_stress + near_contact.size_effect.stress(x, y)
    blending_width = _BLENDING_SHARE * near_contact.limit
    s = np.clip((near_contact.limit - np.hypot(x, y)) / blending_width, 0.0, 1.0)
    weight = (s**2 * (3 - 2 * s))[:, None, None]
    stress = nodal_fields.stress.copy()
    stress[nodes, :3] = (1 - weight) * stress[nodes, :3] + weight * traction_stress
    stress[nodes, 3] = material.poisson_ratio * (stress[nodes, 0] + stress[nodes, 1])
    return stress


def _room(shape: Shape) -> float:
    """Distance from the middle of the face to the nearest support or side of a body [length]."""
    return min(shape.face_half_width, shape.least_depth)


def _counter_clockwise(points: Array, cells: Indices) -> Indices:
    """Node numbers of elements, (n_elements, nodes of one), with those that run clockwise reversed:
    readers of VTU files would give them negative areas.

    `points` are (n, 2), `cells` list corners, then mid-side nodes, then the middle.
    """
    n_corners = 3 if cells.shape[1] in (3, 6) else 4
    corners = points[cells[:, :n_corners]]
    next_corners = np.roll(corners, -1, axis=1)
    x = corners[..., 0]
    y = corners[..., 1]
    twice_area = (x * next_corners[..., 1] - next_corners[..., 0] * y).sum(axis=1)
    return np.where(twice_area[:, None] < 0, cells[:, _NODES_OF_MIRRORED[cells.shape[1]]], cells)


def _nodal_stress(
    basis: skfem.Basis, displacement: Array, tension: Array, condensed: CondensedBody
) -> tuple[Array, Array]:
    """Stress xx, yy, xy, zz at the nodes of a body, (n_nodes, 4), by averaging over the elements
    around each node, and the sum of the areas of these elements, (n_nodes,).

    Stress at quadrature points is extrapolated to the nodes of each element, then averaged there
    with the areas as weights.

    # notation: lam, mu Lame's constants; lam without the part that enters through `tension`

    Parameters
    ----------
    basis
        finite-element basis of the displacement
    displacement
        (n_dofs,) values of the displacement in this basis [length]
    tension
        part of lam div(u) that mixed elements have as an unknown of its own, at the corners
        [stress]
    condensed
        the body, with its material and the order of its elements
    """
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
    """Matrix (n_nodes, n_quadrature) that extrapolates values at the quadrature points of an
    element to its nodes, by the polynomial that fits them best in least squares.

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
