"""Displacement and stress in both bodies at chosen instants, from the stored interface states.

Stress is that of the elements, averaged at the nodes; next to the contact that of the tractions,
see `face_stress`. Both have the bulk stress in them: uniform in half-planes, that of the elements
in blocks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import skfem
from numpy.typing import ArrayLike
from skfem.helpers import sym_grad

from halfplane_fe.arrays import Array, Indices
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
    Nodal,
    Rest,
    Tractions,
    fitted_rest,
    tractions,
    with_uncertainty,
)
from halfplane_fe.interface import body_forces
from halfplane_fe.scales import contact_modulus
from halfplane_fe.solve import FiniteElementSolution
from scenes import ContactSolution, HalfPlane, InputError, Scene
from scenes.bodies import Cylinder, Shape, face_of

# VTK's order of an element's nodes the other way round, by number of nodes.
_REFLECTED = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3], 4: [0, 3, 2, 1], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}

_BODIES = ("lower", "upper")
# Distance from the middle of the contact over its half-width up to which the stress at nodes is
# that of the tractions, but no further than this share of the way to the nearest support or side;
# over the last share of it the elements' takes its place.
_OUTER, _OF_BODY, _STEP = 3.0, 0.8, 0.2
# Depth and distance over the half-width from which on elements are good for what the size of the
# body adds.
_BELOW, _BESIDE = 0.15, 1.2
# Pressure of a node over the largest one up to which it is round-off.
_TOUCHES = 1e-9
# Step over the place of a kink of the profile by which its curvature on either side is found.
_STEP_AT_KINK = 1e-3
# Instants at which that is found for a whole cycle; instants of a cycle among which the largest
# tension is looked for.
_SAMPLED, _CANDIDATES = 12, 40


@dataclass(frozen=True, eq=False)
class BodyFields:
    """Nodal fields of one body at one instant, in the common frame (x along the surface, y out of
    the lower body).

    Attributes
    ----------
    name : "lower" or "upper"
    points : (n, 2) undeformed places [length]
    cells : (n_elements, 3, 6, 4 or 9): corners counter-clockwise, mid-side nodes, middle
    displacement : (n, 2) [length]; that of the upper body includes its tangential displacement and
    approach stress : (n, 4) xx, yy, xy, zz [stress]: beside the contact that of the tractions,
    further away carried to each node from its
        elements and averaged there
    von_mises : (n,) [stress]
    edges : (2,) x of the left and right edge of contact, by the tractions; NaN out of contact
    [length] edge_tension, edge_tension_uncertainty : (2,) xx of the face at those edges, which lie
    between nodes [stress]; NaN in a body so
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
    """Fields at the stored steps nearest to the given instants.

    Raises
    ------
    InputError
        For an instant outside the solved time.
    """
    steps = [_step(solution, float(instant)) for instant in instants]
    if not steps:
        return ()
    tension, uncertain = edge_tension(solution, steps)
    pairs = [with_uncertainty(_nodal(solution, step)) for step in steps]
    bodies = []
    for number, name in enumerate(_BODIES):
        side, material, bulk = (
            1.0 - 2.0 * number,
            solution.condensed[number].material,
            _bulk_stress(solution, steps, number),
        )
        basis, displacements, stresses, _ = _stress(solution, number, steps, pairs, bulk)
        places = basis.mesh.p
        moved = displacements.reshape(places.shape[1], 2, -1).swapaxes(0, 1)  # (2, n_nodes, k)
        if isinstance(getattr(solution.scene.bodies, name), HalfPlane):
            moved = moved + uniform_stretch(material, *places)[..., None] * bulk
            stresses = stresses + np.array([1.0, 0.0, 0.0, material.poisson_ratio])[:, None] * bulk
        points = places.T * [1.0, side]
        cells = _counter_clockwise(points, cells_of(basis.mesh, solution.condensed[number].order))
        found = []
        for k, (step, (series, _)) in enumerate(zip(steps, pairs, strict=True)):
            displacement, stress = (
                moved[..., k].T * [1.0, side],
                stresses[..., k]
                * [
                    1.0,
                    1.0,
                    side,
                    1.0,
                ],
            )
            if number:
                tilt = 0.0 if solution.tilt is None else solution.tilt[step]
                displacement = displacement + tilt * points[:, ::-1] * [-1.0, 1.0]
                displacement += [
                    solution.tangential_displacement[step],
                    -solution.normal_approach[step],
                ]
            edges = np.array(series.edges if series is not None else (np.nan, np.nan))
            of_edges = edges, tension[k, number], uncertain[k, number]
            found.append(
                BodyFields(name, points, cells, displacement, stress, _von_mises(stress), *of_edges)
            )
        bodies.append(found)
    times, normal, tangential = (
        values.tolist()
        for values in (solution.time, solution.normal_load, solution.tangential_load)
    )
    pairs_of_bodies = zip(steps, *bodies, strict=True)
    return tuple(
        Snapshot(times[step], normal[step], tangential[step], (lower, upper))
        for step, lower, upper in pairs_of_bodies
    )


def _step(solution: FiniteElementSolution, instant: float) -> int:
    start, end = float(solution.time[0]), float(solution.time[-1])
    if not start - 1e-9 <= instant <= end + 1e-9:
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
    values, uncertainties : (n_steps, 2, 2) by body (lower, upper) and edge (left, right); 0 out of
        contact; NaN in a body so thin that what its size adds is not known

    Raises
    ------
    InputError
        For bodies of finite size whose meshes are not there: answers that were read back from disk
        have none.
    """
    if not (solution.scene.bodies.half_planes or isinstance(solution, FiniteElementSolution)):
        raise InputError(
            "edge_tension: the answer has no meshes, so what the size of its bodies adds is not"
            " known; solve it again"
        )
    pairs = [with_uncertainty(_nodal(solution, step)) for step in steps]
    values, uncertain = np.zeros((len(steps), 2, 2)), np.zeros((len(steps), 2, 2))
    there = [(k, found) for k, (found, _) in enumerate(pairs) if found is not None]
    for k, found in there:
        values[k], uncertain[k] = np.outer([1.0, -1.0], found.edge_tension()), pairs[k][1]
    rows = [k for k, _ in there]
    for number, name in enumerate(_BODIES if there else ()):
        bulk = _bulk_stress(solution, [steps[k] for k in rows], number)
        if isinstance(getattr(solution.scene.bodies, name), HalfPlane):
            values[rows, number] += bulk[:, None]
            continue
        assert isinstance(solution, FiniteElementSolution)  # for the type checker
        # What the body adds is linear in tractions and bulk stress, and hardly depends on more than
        # moments of the former: found at a few instants.
        at = sorted(set(np.linspace(0, len(rows) - 1, _SAMPLED).round().astype(int).tolist()))
        chosen = [rows[k] for k in at]
        rest = _stress(
            solution,
            number,
            [steps[k] for k in chosen],
            [pairs[k] for k in chosen],
            bulk[at],
            rest_alone=True,
        )[3]
        if rest is None:
            values[rows, number] = uncertain[rows, number] = np.nan
            continue
        causes = np.array([found.moments() for _, found in there])
        # Over P and powers of the half-width: moments that are zero by symmetry must not count as
        # round-off over round-off.
        scale = np.abs(causes[:, 0]).max() * max(
            found.half_width for _, found in there
        ) ** np.array([0, 1, 2, 0, 1, 2])
        if bulk.any():
            causes, scale = np.column_stack([causes, bulk]), np.append(scale, np.abs(bulk).max())
        slopes = np.linalg.lstsq(causes[at] / scale, rest.coefficients.T, rcond=1e-8)[0]
        whole = replace(rest, coefficients=(causes / scale @ slopes).T)
        for column, (k, found) in enumerate(there):
            values[k, number] += whole.stress(np.array(found.edges), np.zeros(2))[:, 0, column]
        missed = (
            rest.stress(np.zeros(1), np.zeros(1)) - whole.stress(np.zeros(1), np.zeros(1))[..., at]
        )
        uncertain[rows, number] += float(rest.error.max() + np.abs(missed[:, 0]).max())
    return values, uncertain


def stress(
    solution: FiniteElementSolution,
    x: ArrayLike,
    y: ArrayLike,
    instants: ArrayLike,
    *,
    body: Literal["lower", "upper"] = "lower",
) -> Array:
    """Stress next to the contact at any place of one body, from the tractions, at the stored steps
    nearest to instants.

    Parameters
    ----------
    x, y : (n_points,) places [length]; y points out of the lower body and counts from a face that
        is flattened, so that y <= 0 in the lower body, y >= 0 in the upper one
    instants : (n_instants,) times
    body : "lower" or "upper"

    Returns
    -------
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
    side = 1.0 if body == "lower" else -1.0
    across, depth = np.broadcast_arrays(
        np.atleast_1d(np.asarray(x, dtype=float)), np.atleast_1d(side * np.asarray(y, dtype=float))
    )
    if np.any(depth > 0):
        raise InputError(
            f"stress: y = {side * float(depth.max()):.6g} is outside the {body} body; y points out"
            " of the lower one"
        )
    pairs, number = (
        [with_uncertainty(_nodal(solution, step)) for step in steps],
        int(body == "upper"),
    )
    found, bulk = np.zeros((len(steps), len(across), 4)), _bulk_stress(solution, steps, number)
    for k, (series, _) in enumerate(pairs):
        if series is not None:
            found[k, :, :3] = replace(series, shear=side * series.shear).stress(across, depth)
    if isinstance(getattr(solution.scene.bodies, body), HalfPlane):
        found[..., 0] += bulk[:, None]
    elif any(series is not None for series, _ in pairs):
        rest = _stress(solution, number, steps, pairs, bulk, rest_alone=True)[3]
        if rest is None or np.any(np.hypot(across, depth) > rest.length * (1 + 1e-9)):
            raise InputError(
                f"stress: a place in the {body} body is further from the contact than where the"
                " tractions alone give its stress"
            )
        found[..., :3] += np.moveaxis(rest.stress(across, depth), -1, 0)
    found[..., 2] *= side
    found[..., 3] = solution.condensed[number].material.poisson_ratio * (
        found[..., 0] + found[..., 1]
    )
    return found


@dataclass(frozen=True)
class LargestTension:
    """The largest tension s_xx of a cycle at an edge of contact with its uncertainty [stress], its
    time and body.

    `edges` are the left and right edge of contact at that time, `x` the one that it is at [length].
    """

    value: float
    uncertainty: float
    time: float
    body: str
    x: float
    edges: tuple[float, float]


def largest_edge_tension(solution: ContactSolution) -> LargestTension | None:
    """The largest `edge_tension` of the last cycle; None where it is not known, and out of contact.

    That at which the value less its uncertainty is largest: where a load has just turned, elements
    see no more than that the new slip zone is narrow, and the tension that they still have says
    little.
    """
    if not (solution.scene.bodies.half_planes or isinstance(solution, FiniteElementSolution)):
        return None
    cycle = np.asarray(solution.last_cycle)
    rough = np.full(len(cycle), -np.inf)
    for number, step in enumerate(cycle.tolist()):
        nodal = _nodal(solution, step)
        if len(nodal.x) >= FEWEST:
            rough[number] = np.abs(tractions(nodal).edge_tension()).max()
    steps = np.sort(
        cycle[np.argsort(-rough, kind="stable")[: min(_CANDIDATES, int(np.isfinite(rough).sum()))]]
    ).tolist()
    if not steps:
        return None
    values, uncertain = edge_tension(solution, steps)
    if np.isnan(values).any():
        return None
    k, body, edge = (
        int(index) for index in np.unravel_index(np.argmax(values - uncertain), values.shape)
    )
    edges = tractions(_nodal(solution, steps[k])).edges
    size = float(values[k, body, edge]), float(uncertain[k, body, edge])
    return LargestTension(
        *size, float(solution.time[steps[k]]), ("lower", "upper")[body], edges[edge], edges
    )


def _bulk_stress(solution: ContactSolution, steps: Sequence[int], number: int) -> Array:
    """(n_steps,) bulk stress of the lower (0) or the upper (1) body [stress]."""
    found = (solution.bulk_stress_lower, solution.bulk_stress_upper)[number]
    return np.zeros(len(steps)) if found is None else np.asarray(found[list(steps)])


def _nodal(solution: ContactSolution, step: int) -> Nodal:
    """Nodal tractions at a stored step."""
    x, pressure, shear, friction = (
        solution.x,
        solution.pressure[step],
        solution.shear[step],
        solution.scene.friction.coefficient,
    )
    # A node that just meets or leaves the other face has no pressure but round-off: it counts as
    # open, whatever that is.
    closed, before = pressure > _TOUCHES * np.max(pressure), max(step - 1, 0)
    loads = (solution.normal_load, solution.tangential_load)
    rise, drag = (float(load[step] - load[before]) for load in loads)
    (left, right), (first, last) = (
        solution.stick_edges[step].tolist(),
        solution.contact_edges[step].tolist(),
    )
    carried = float(solution.tangential_load[step])
    if solution.scene.bodies.faces_are_true and isinstance(solution, FiniteElementSolution):
        carried = float(shear @ solution.weights)  # on curved faces p carries a part of Q
    # With bulk stress or tilt each edge has a law of its own: taken for unknown, which makes the
    # uncertainty larger, not smaller.
    growing = rise > 0 and abs(drag) <= friction * rise and solution.tilt is None
    kinks = profile_kinks(solution.scene)
    return Nodal(
        x[closed],
        pressure[closed],
        shear[closed],
        (left, right),
        (first, last),
        friction,
        carried,
        growing,
        kinks,
    )


def profile_kinks(scene: Scene) -> Array:
    """(k, 2) where the curvature of the gap jumps, and E* times by how much from left to right
    [length, stress/length].
    """
    found = []
    for place in scene.profile.kinks:
        step = _STEP_AT_KINK * place
        height = scene.profile.height(place + step * np.arange(-2, 3))
        # second differences of either side
        jump = (height[4] - 2 * height[3] + 2 * height[1] - height[0]) / step**2
        found += [(place, jump), (-place, -jump)]
    return np.array(found).reshape(-1, 2) * [
        1.0,
        contact_modulus(scene.material.lower, scene.material.upper),
    ]


def _stress(
    solution: FiniteElementSolution,
    number: int,
    steps: Sequence[int],
    pairs: Sequence[tuple[Tractions | None, Array]],
    bulk: Array,
    rest_alone: bool = False,
) -> tuple[skfem.Basis, Array, Array, Rest | None]:
    """Basis and displacements of a body at stored steps; its stress (n, 4, k) at the nodes; what
    its size adds, None if unknown.

    The body, 0 the lower or 1 the upper one, is in its own frame; `pairs` are the tractions on the
    lower one.

    The bulk stress (k,) is in all of it, but for that of a half-plane. With `rest_alone` the stress
    is that of the elements alone.

    Beside the contact stress is that of the tractions on a half-plane and what the size of the body
    adds; further away that of the elements; a smooth step leads from the one to the other. Faces
    that are not flat are flattened for it.
    """
    condensed, shape = solution.condensed[number], getattr(solution.scene.bodies, _BODIES[number])
    states = [solution.states[step] for step in steps]
    loads = (
        np.stack([getattr(state, what) for state in states], axis=1) * solution.scales.load
        for what in ("pressure", "shear")
    )
    forces = body_forces(*solution.condensed, *loads)[_BODIES[number]]
    basis, displacements, tensions = displacement_fields(
        condensed, forces, solution.scene.profile.datum_length, bulk
    )
    nodal = [
        _nodal_stress(basis, *case, condensed)
        for case in zip(displacements.T, tensions.T, strict=True)
    ]
    stress, weights = np.stack([part for part, _ in nodal], axis=-1), nodal[0][1]
    touching = [found.half_width for found, _ in pairs if found is not None]
    if not touching:
        return basis, displacements, stress, None
    edge = max(touching)
    far = min(_OUTER * edge, _OF_BODY * _room(shape))
    if far < 1.5 * edge:  # so thin that all of it is next to the contact: the elements alone
        return basis, displacements, stress, None
    x, y = (
        basis.mesh.p[0],
        np.minimum(
            basis.mesh.p[1] + face_of(shape, solution.scene.profile).depth(np.abs(basis.mesh.p[0])),
            0.0,
        ),
    )
    near = np.flatnonzero(np.hypot(x, y) < far)
    x, y, side = x[near], y[near], 1.0 - 2.0 * number
    series = [
        None if found is None else replace(found, shear=side * found.shear) for found, _ in pairs
    ]

    def of_half_plane(x: Array, y: Array) -> Array:
        return np.stack(
            [np.zeros((len(x), 3)) if one is None else one.stress(x, y) for one in series], axis=-1
        )

    rest = None
    if not isinstance(shape, HalfPlane):
        good = (y < -_BELOW * edge) | ((np.abs(x) > _BESIDE * edge) & (y < 0))
        beyond = stress[near][good, :3] - of_half_plane(x[good], y[good])
        rest = fitted_rest(x[good], y[good], beyond, weights[near][good], far, edge)
    if rest_alone:
        return basis, displacements, stress, rest
    local = of_half_plane(x, y) + (0.0 if rest is None else rest.stress(x, y))
    share = np.clip((far - np.hypot(x, y)) / (_STEP * far), 0.0, 1.0)
    share = (share**2 * (3 - 2 * share))[:, None, None]
    stress[near, :3] = (1 - share) * stress[near, :3] + share * local
    stress[near, 3] = condensed.material.poisson_ratio * (stress[near, 0] + stress[near, 1])
    return basis, displacements, stress, rest


def _room(shape: Shape) -> float:
    """Distance from the middle of the face to the nearest support or side of a body [length]."""
    if isinstance(shape, HalfPlane):
        return math.inf
    return shape.radius if isinstance(shape, Cylinder) else min(shape.width / 2, shape.height)


def _counter_clockwise(points: Array, cells: Indices) -> Indices:
    """`cells` with those that go round clockwise reversed: readers of VTU would give them negative
    areas.
    """
    corners = points[cells[:, : 3 if cells.shape[1] in (3, 6) else 4]]
    ahead = np.roll(corners, -1, axis=1)
    twice_area = (corners[..., 0] * ahead[..., 1] - ahead[..., 0] * corners[..., 1]).sum(axis=1)
    return np.where(twice_area[:, None] < 0, cells[:, _REFLECTED[cells.shape[1]]], cells)


def _nodal_stress(
    basis: skfem.Basis, displacement: Array, tension: Array, condensed: CondensedBody
) -> tuple[Array, Array]:
    """(n_nodes, 4) xx, yy, xy, zz: element stresses carried to each node and averaged there with
    the elements' areas as weights.

    And (n_nodes,) the sum of these areas.
    """
    # notation: lam, mu are Lame's constants, the part of lam that enters through `tension` left out
    lam, _, mu = split_lame(condensed.material, condensed.order)
    strain = sym_grad(basis.interpolate(displacement))
    corners = basis.with_element(scalar_element(basis.mesh, 1)).interpolate(tension)
    mean = lam * (strain[0, 0] + strain[1, 1]) + np.asarray(corners)
    parts = np.stack(
        (mean + 2 * mu * strain[0, 0], mean + 2 * mu * strain[1, 1], 2 * mu * strain[0, 1], mean)
    )
    at_nodes = parts @ _to_nodes(basis, condensed.order).T
    area, cells, n_nodes = (
        basis.dx.sum(axis=1)[:, None],
        cells_of(basis.mesh, condensed.order).ravel(),
        basis.mesh.p.shape[1],
    )
    weights = np.bincount(cells, np.broadcast_to(area, at_nodes.shape[1:]).ravel(), n_nodes)
    stress = np.column_stack(
        [np.bincount(cells, (area * part).ravel(), n_nodes) / weights for part in at_nodes]
    )
    return stress, np.asarray(weights, dtype=float)


def _to_nodes(basis: skfem.Basis, order: int) -> Array:
    """(n_nodes, n_quadrature) of an element: values at its nodes of the polynomial nearest to those
    at its quadrature points.

    Of an order less than the displacement has, where stresses are most accurate: constant, or
    linear (bilinear on a quadrilateral).

    Source: Zienkiewicz and Zhu (1992), Int. J. Numer. Meth. Engng 33, 1331-1364, for the points of
    most accurate stress.
    """
    refdom = basis.mesh.refdom
    ends = np.asarray(refdom.p, dtype=float)
    places = [
        ends,
        *([ends[:, np.array(refdom.facets).T].mean(axis=1)] if basis.facet_dofs.size else []),
    ]
    if basis.interior_dofs.size:
        places.append(ends.mean(axis=1, keepdims=True))

    def polynomial(at: Array) -> Array:
        terms = [np.ones(at.shape[1]), *at, at[0] * at[1]]
        return np.column_stack(terms[: 1 if order == 1 else refdom.nnodes])

    root = np.sqrt(basis.W)[:, None]
    return np.asarray(
        polynomial(np.hstack(places)) @ np.linalg.pinv(root * polynomial(basis.X)) * root.T
    )


def _von_mises(stress: Array) -> Array:
    xx, yy, xy, zz = stress.T
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)
