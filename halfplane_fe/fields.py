"""Displacement and stress in both bodies at chosen instants, from the stored interface states."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import skfem
from numpy.typing import NDArray
from skfem.helpers import sym_grad

from halfplane_fe.elasticity import CondensedBody, displacement_fields, scalar_element, split_lame
from halfplane_fe.interface import body_forces
from halfplane_fe.solve import FiniteElementSolution
from scenes import InputError

Array = NDArray[np.float64]

# VTK's order of an element's nodes the other way round, by number of nodes.
_REFLECTED = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3], 4: [0, 3, 2, 1], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}


@dataclass(frozen=True, eq=False)
class BodyFields:
    """Nodal fields of one body at one instant, in the common frame (x along the surface, y out of the lower body).

    Attributes
    ----------
    name : "lower" or "upper"
    points : (n, 2) undeformed places [length]
    cells : (n_elements, 3, 6, 4 or 9): corners counter-clockwise, mid-side nodes, middle
    displacement : (n, 2) [length]; that of the upper body includes its tangential displacement and approach
    stress : (n, 4) xx, yy, xy, zz [stress], carried to each node from its elements and averaged there
    von_mises : (n,) [stress]
    """

    name: str
    points: Array
    cells: NDArray[np.int64]
    displacement: Array
    stress: Array
    von_mises: Array


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
    nodal = (
        np.stack([getattr(solution.states[step], name) for step in steps], axis=1) * solution.scales.load
        for name in ("pressure", "shear")
    )
    forces = body_forces(*solution.condensed, *nodal)
    bodies = {name: _body_fields(name, solution.condensed[name == "upper"], forces[name], solution) for name in forces}
    return tuple(
        Snapshot(
            float(solution.time[step]),
            float(solution.normal_load[step]),
            float(solution.tangential_load[step]),
            (bodies["lower"][k], _moved(bodies["upper"][k], solution, step)),
        )
        for k, step in enumerate(steps)
    )


def _step(solution: FiniteElementSolution, instant: float) -> int:
    start, end = float(solution.time[0]), float(solution.time[-1])
    if not start - 1e-9 <= instant <= end + 1e-9:
        raise InputError(f"fields: instant {instant:.6g} lies outside the solved time, {start:.6g} to {end:.6g}")
    return int(np.argmin(np.abs(solution.time - instant)))


def _body_fields(name: str, condensed: CondensedBody, forces: Array, solution: FiniteElementSolution) -> list[BodyFields]:
    """Fields of a body for each column of `forces` (2, n, k); the upper body is reflected into the common frame."""
    basis, displacements, tensions = displacement_fields(condensed, forces, solution.scene.profile.datum_length)
    flip = np.array([1.0, 1.0 if name == "lower" else -1.0])
    nodes = _node_dofs(basis)
    points = basis.mesh.p.T * flip
    cells = _counter_clockwise(points, _cells(basis))
    found = []
    for values, tension in zip(displacements.T, tensions.T, strict=True):
        stress = _nodal_stress(basis, values, tension, condensed)
        stress[:, 2] *= flip[1]
        found.append(BodyFields(name, points, cells, values[nodes].T * flip, stress, _von_mises(stress)))
    return found


def _moved(body: BodyFields, solution: FiniteElementSolution, step: int) -> BodyFields:
    rigid = np.array([solution.tangential_displacement[step], -solution.normal_approach[step]])
    return BodyFields(body.name, body.points, body.cells, body.displacement + rigid, body.stress, body.von_mises)


def _node_dofs(basis: skfem.Basis) -> NDArray[np.int64]:
    """(2, n_nodes) degrees of freedom of the mesh's nodes: corners, mid-side points, middles of quadrilaterals."""
    return np.hstack([dofs for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs) if dofs.size])


def _cells(basis: skfem.Basis) -> NDArray[np.int64]:
    corners = basis.mesh.t[: basis.mesh.refdom.nfacets]
    parts, first = [corners], basis.nodal_dofs.shape[1]
    # scikit-fem numbers the facets 01, 12, 02 of a triangle and 01, 12, 23, 03 of a quadrilateral, as VTK does its mid-side nodes.
    if basis.facet_dofs.size:
        parts.append(first + basis.mesh.t2f)
        first += basis.mesh.facets.shape[1]
    if basis.interior_dofs.size:
        parts.append(first + np.arange(corners.shape[1])[None, :])
    return np.vstack(parts).T.astype(np.int64)


def _counter_clockwise(points: Array, cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """`cells` with those that go round clockwise reversed: readers of VTU would give them negative areas."""
    corners = points[cells[:, : 3 if cells.shape[1] in (3, 6) else 4]]
    ahead = np.roll(corners, -1, axis=1)
    twice_area = (corners[..., 0] * ahead[..., 1] - ahead[..., 0] * corners[..., 1]).sum(axis=1)
    return np.where(twice_area[:, None] < 0, cells[:, _REFLECTED[cells.shape[1]]], cells)


def _nodal_stress(basis: skfem.Basis, displacement: Array, tension: Array, condensed: CondensedBody) -> Array:
    """(n_nodes, 4) xx, yy, xy, zz: element stresses carried to each node and averaged there with the elements' areas as weights."""
    # notation: lam, mu are Lame's constants, the part of lam that enters through `tension` left out
    lam, _, mu = split_lame(condensed.material, condensed.order)
    strain = sym_grad(basis.interpolate(displacement))
    corners = basis.with_element(scalar_element(basis.mesh, 1)).interpolate(tension)
    mean = lam * (strain[0, 0] + strain[1, 1]) + np.asarray(corners)
    parts = np.stack((mean + 2 * mu * strain[0, 0], mean + 2 * mu * strain[1, 1], 2 * mu * strain[0, 1], mean))
    at_nodes = parts @ _to_nodes(basis, condensed.order).T
    area, cells, n_nodes = basis.dx.sum(axis=1)[:, None], _cells(basis).ravel(), basis.mesh.p.shape[1]
    weights = np.bincount(cells, np.broadcast_to(area, at_nodes.shape[1:]).ravel(), n_nodes)
    return np.column_stack([np.bincount(cells, (area * part).ravel(), n_nodes) / weights for part in at_nodes])


def _to_nodes(basis: skfem.Basis, order: int) -> Array:
    """(n_nodes, n_quadrature) of an element: values at its nodes of the polynomial nearest to those at its quadrature points.

    Of an order less than the displacement has, where stresses are most accurate: constant, or linear (bilinear on a quadrilateral).

    Source: Zienkiewicz and Zhu (1992), Int. J. Numer. Meth. Engng 33, 1331-1364, for the points of most accurate stress.
    """
    refdom = basis.mesh.refdom
    ends = np.asarray(refdom.p, dtype=float)
    places = [ends, *([ends[:, np.array(refdom.facets).T].mean(axis=1)] if basis.facet_dofs.size else [])]
    if basis.interior_dofs.size:
        places.append(ends.mean(axis=1, keepdims=True))

    def polynomial(at: Array) -> Array:
        terms = [np.ones(at.shape[1]), *at, at[0] * at[1]]
        return np.column_stack(terms[: 1 if order == 1 else refdom.nnodes])

    root = np.sqrt(basis.W)[:, None]
    return np.asarray(polynomial(np.hstack(places)) @ np.linalg.pinv(root * polynomial(basis.X)) * root.T)


def _von_mises(stress: Array) -> Array:
    xx, yy, xy, zz = stress.T
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xy**2)
