"""Plane-strain elasticity of one body, condensed to the nodes that may touch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu
from skfem.models.elasticity import lame_parameters, linear_elasticity

from halfplane_fe.far_field import surface_force_displacement
from meshes import BodyMesh
from scenes import ConvergenceError, Elastic, freeze

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Right-hand sides per call of SuperLU: twice as fast here as all at once, since a block stays in the cache.
_BLOCK = 32


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """A body seen from its contact nodes: what unit nodal forces on them do.

    Attributes
    ----------
    body, material : what was condensed
    x : (n,) contact nodes in ascending order [length]
    weights : (n,) integral of each node's shape function over the surface [length]
    compliance : (2, n, 2, n) displacement (along x, outward) of node i by a unit force (along x, outward) on node j,
        symmetric [length per force per thickness]
    diagnostics : asymmetry (largest skew part over largest entry; the far field's discretisation), residual (of the solves)
    """

    body: BodyMesh
    material: Elastic
    x: Array
    weights: Array
    compliance: Array
    diagnostics: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _System:
    """The assembled body: stiffness, and which degrees of freedom are what."""

    basis: skfem.Basis
    stiffness: sparse.csr_matrix
    contact: Indices  # (2, n) degrees of freedom (x, y) of the contact nodes, by ascending x
    arc: Indices  # (2, m) those of the far-field arc
    free: Indices  # all that is not on the arc


def _element(order: int) -> skfem.ElementVector:
    return skfem.ElementVector(skfem.ElementTriP2() if order == 2 else skfem.ElementTriP1())


def _boundary_dofs(basis: skfem.Basis, name: str) -> Indices:
    """(2, n) degrees of freedom (x, y) of a named boundary, by ascending x, then y."""
    dofs = basis.get_dofs(name)
    components = [dofs.all([f"u^{component}"]) for component in ("1", "2")]
    places = basis.doflocs[:, components[0]]
    order = np.lexsort((places[1], places[0]))
    return np.array([np.asarray(one)[order] for one in components], dtype=np.int64)


def _assemble(body: BodyMesh, material: Elastic) -> _System:
    order = 2 if isinstance(body.mesh, skfem.MeshTri2) else 1
    basis = skfem.Basis(body.mesh, _element(order), intorder=2 * order)
    form = linear_elasticity(*lame_parameters(material.young_modulus, material.poisson_ratio))
    contact, arc = _boundary_dofs(basis, "contact"), _boundary_dofs(basis, "far_field")
    free = np.setdiff1d(np.arange(basis.N), arc)
    return _System(basis, form.assemble(basis).tocsr(), contact, arc, free)


def _surface_weights(basis: skfem.Basis, contact: Indices) -> Array:
    """Integral over the contact boundary of each contact node's shape function."""
    facets = skfem.FacetBasis(basis.mesh, basis.elem, facets=basis.mesh.boundaries["contact"], intorder=4)
    along_x = skfem.LinearForm(lambda v, w: v[0] + 0 * w.x[0])
    return np.asarray(along_x.assemble(facets))[contact[0]]


def _arc_displacement(system: _System, material: Elastic, datum_length: float) -> Array:
    """(2 m, 2 n): displacement of the arc by unit forces on the contact nodes, half-plane theory."""
    places, forces = system.basis.doflocs[:, system.arc[0]], system.basis.doflocs[0, system.contact[0]]
    kernel = surface_force_displacement(places[0], places[1], forces, material.young_modulus, material.poisson_ratio, datum_length)
    return kernel.reshape(2 * places.shape[1], 2 * len(forces))


def _factorise(stiffness: sparse.csc_matrix) -> SuperLU:
    # Symmetric positive definite: no pivoting, minimum degree on A + A^T (5 times faster here than the default order).
    return splu(stiffness, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def _unit_force_fields(system: _System, arc_displacement: Array) -> tuple[Array, float]:
    """(n_free, 2 n) displacements of the free nodes by unit forces on the contact nodes, and the relative residual."""
    rows = system.stiffness[system.free]
    arc, contact = system.arc.ravel(), system.contact.ravel()
    place = np.full(system.basis.N, -1)
    place[system.free] = np.arange(len(system.free))
    load = -(rows[:, arc] @ arc_displacement)
    load[place[contact], np.arange(len(contact))] += 1.0
    inner = rows[:, system.free].tocsc()
    factors = _factorise(inner)
    fields = np.empty_like(load)
    for start in range(0, load.shape[1], _BLOCK):
        block = np.s_[:, start : start + _BLOCK]
        fields[block] = factors.solve(np.asfortranarray(load[block]))
    residual = float(np.abs(inner @ fields - load).max() / np.abs(load).max())
    if not residual < 1e-8:
        raise ConvergenceError(f"condensation: the sparse factorisation left a relative residual of {residual:.1e}")
    return fields, residual


def condense(body: BodyMesh, material: Elastic, datum_length: float) -> CondensedBody:
    """Condense a half-disc to its contact nodes, the arc following the nodal forces by half-plane theory.

    Parameters
    ----------
    body : mesh with the boundaries "contact" and "far_field"
    material : of the body
    datum_length : distance from a force at which a half-plane's surface counts as unmoved [length]

    Raises
    ------
    ConvergenceError
        If the sparse solve leaves a residual above 1e-8.
    """
    system = _assemble(body, material)
    fields, residual = _unit_force_fields(system, _arc_displacement(system, material, datum_length))
    place = np.searchsorted(system.free, system.contact.ravel())
    compliance = fields[place]
    # Betti: exact far field and exact elasticity make it symmetric; the discrete one is so up to the arc's mesh error.
    asymmetry = float(np.abs(compliance - compliance.T).max() / np.abs(compliance).max())
    n = system.contact.shape[1]
    return CondensedBody(
        body,
        material,
        freeze(system.basis.doflocs[0, system.contact[0]]),
        freeze(_surface_weights(system.basis, system.contact)),
        freeze((compliance + compliance.T).reshape(2, n, 2, n) / 2),
        {"asymmetry": asymmetry, "residual": residual, "degrees_of_freedom": float(system.basis.N)},
    )


def displacement_fields(condensed: CondensedBody, forces: Array, datum_length: float) -> tuple[skfem.Basis, Array]:
    """Displacement of the whole body under nodal contact forces.

    Parameters
    ----------
    forces : (2, n, k) along x and outward on the contact nodes, k load cases [force per thickness]

    Returns
    -------
    basis : of the body
    displacements : (basis.N, k) [length]
    """
    system = _assemble(condensed.body, condensed.material)
    cases = forces.reshape(-1, forces.shape[-1])
    displacements = np.zeros((system.basis.N, forces.shape[-1]))
    displacements[system.arc.ravel()] = _arc_displacement(system, condensed.material, datum_length) @ cases
    load = np.zeros_like(displacements)
    load[system.contact.ravel()] = cases
    rows = system.stiffness[system.free]
    inner = rows[:, system.free].tocsc()
    displacements[system.free] = _factorise(inner).solve(load[system.free] - rows @ displacements)
    return system.basis, displacements
