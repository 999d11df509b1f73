"""Plane-strain elasticity of one body, condensed to the nodes that may touch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse.linalg import SuperLU, splu

from halfplane_fe.assembly import System, assemble, order_of, split_lame, surface_weights
from halfplane_fe.far_field import arc_work, rigid_motions, surface_force_displacement
from meshes import BodyMesh
from scenes import ConvergenceError, Elastic, freeze

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """A body seen from its contact nodes: what unit nodal forces on them do.

    Attributes
    ----------
    body, material : what was condensed
    x, y : (n,) places of the contact nodes in ascending order of x; y = 0 on a flat face [length]
    weights : (n,) integral of each node's shape function over the surface [length]
    compliance : (2, n, 2, n) displacement (along x, outward) of node i by a unit force (along x, outward) on node j,
        symmetric [length per force per thickness]
    diagnostics : asymmetry (largest skew part over largest entry: rounding), residual (of the
        elimination), degrees_of_freedom, sparse_factorisations
    """

    body: BodyMesh
    material: Elastic
    x: Array
    y: Array
    weights: Array
    compliance: Array
    diagnostics: Mapping[str, float] = field(default_factory=dict)

    @property
    def order(self) -> int:
        """Order of the elements, 1 or 2."""
        return order_of(self.body.mesh)


def _arc_displacement(system: System, material: Elastic, datum_length: float, moments: int | None = None) -> Array:
    """(2 m, 2 n): displacement of the arc by unit forces on the contact nodes, half-plane theory."""
    places, forces = system.basis.doflocs[:, system.arc[0]], system.basis.doflocs[0, system.contact[0]]
    young, nu = material.young_modulus, material.poisson_ratio
    kernel = surface_force_displacement(places[0], places[1], forces, young, nu, datum_length, moments)
    return kernel.reshape(2 * places.shape[1], 2 * len(forces))


def factorise(stiffness: sparse.csc_matrix, ordering: str = "MMD_AT_PLUS_A") -> SuperLU:
    """Sparse factors of a stiffness that is symmetric, positive or quasi-definite [stress]: no pivoting, in the order asked for."""
    # Minimum degree on A + A^T is 5 times faster here than the default order.
    return splu(stiffness, permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def _interface_stiffness(system: System) -> tuple[Array, float]:
    """Stiffness of the contact and arc nodes (2 n + 2 m), all others eliminated, and its residual.

    The kept nodes stand last in the order of elimination, so that their stiffness is the trailing block of the factors: three to
    five times faster than solving for each unit force.
    """
    kept = np.concatenate([system.contact.ravel(), system.arc.ravel()])
    stiffness = system.stiffness
    inner = np.setdiff1d(system.free, system.contact.ravel())
    inner_factors = factorise(stiffness[inner][:, inner].tocsc())
    order = np.concatenate([inner[np.argsort(inner_factors.perm_c)], kept])
    # A half-disc floats: stiffening the arc, eliminated last of all, keeps its pivots off zero.
    stiffer = np.zeros(stiffness.shape[0])
    stiffer[system.arc.ravel()] = stiffness.diagonal().max()
    factors = factorise((stiffness + sparse.diags(stiffer))[order][:, order].tocsc(), "NATURAL")
    last = slice(len(inner), None)
    found = factors.L[last, last].toarray() @ factors.U[last, last].toarray() - np.diag(stiffer[kept])
    residual = _elimination_residual(stiffness, inner_factors, inner, kept, found)
    if not residual < 1e-8:
        raise ConvergenceError(f"condensation: the sparse factorisation left a relative residual of {residual:.1e}")
    return (found + found.T) / 2, residual


def _elimination_residual(
    stiffness: sparse.csr_matrix, inner_factors: SuperLU, inner: Indices, kept: Indices, found: Array
) -> float:
    """Relative error of the forces that `found` gives for one displacement of the kept nodes, against solving for it."""
    rng = np.random.default_rng(0)
    displacement = np.zeros(stiffness.shape[0])
    displacement[kept] = rng.standard_normal(len(kept))
    displacement[inner] = inner_factors.solve(-(stiffness[inner] @ displacement))
    forces = stiffness[kept] @ displacement
    return float(np.abs(found @ displacement[kept] - forces).max() / np.abs(forces).max())


def _compliance(system: System, stiffness: Array, material: Elastic, datum_length: float) -> Array:
    """(2 n, 2 n): displacement of the contact nodes by unit forces on them; the arc carries the half-plane's tractions."""
    if not system.arc.size:
        return cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
    by_nodes, by_half_plane = _arc_work(system, material, datum_length)
    loads = np.vstack([np.eye(system.contact.size), by_nodes[system.arc.ravel()]])
    # The loads balance, so that holding the body in its three rigid motions changes nothing.
    rigid, _ = np.linalg.qr(rigid_motions(system.basis)[np.concatenate([system.contact.ravel(), system.arc.ravel()])])
    held = stiffness + np.abs(stiffness).max() * rigid @ rigid.T
    return loads.T @ cho_solve(cho_factor(held, overwrite_a=True), loads) - by_half_plane


def _arc_work(system: System, material: Elastic, datum_length: float) -> tuple[Array, Array]:
    """See `far_field.arc_work`."""
    facets = np.concatenate([np.empty(0, dtype=np.int64), *(system.basis.mesh.boundaries[name] for name in system.around)])
    return arc_work(system.basis, facets, system.basis.doflocs[0, system.contact[0]], material, datum_length)


def _rigid_part(system: System, displacement: Array) -> Array:
    """(basis.N, k): the rigid motion next to a displacement (2 n, k) of the contact nodes."""
    motions = rigid_motions(system.basis)
    return motions @ np.linalg.lstsq(motions[system.contact.ravel()], displacement, rcond=None)[0]


def truncated_compliance(body: BodyMesh, material: Elastic, datum_length: float, moments: int | None) -> Array:
    """(2, n, 2, n) compliance with the displacement of the first `moments` of the nodal forces prescribed on the arc: for studies.

    It is not made symmetric: the mean with its transpose would carry the error of the rigid shift, (a/L)^2, into the tractions.
    """
    system = assemble(body, material)
    stiffness, n = _interface_stiffness(system)[0], system.contact.shape[1]
    by_contact, by_arc = stiffness[: 2 * n, : 2 * n], stiffness[: 2 * n, 2 * n :]
    # f = S_cc u_c + S_ca u_a with u_a = G f, hence u_c = S_cc^-1 (1 - S_ca G) f.
    right = np.eye(2 * n) - by_arc @ _arc_displacement(system, material, datum_length, moments)
    return cho_solve(cho_factor(by_contact), right).reshape(2, n, 2, n)


def condense(body: BodyMesh, material: Elastic, datum_length: float) -> CondensedBody:
    """Condense a body to its contact nodes; the arc of a half-disc carries the tractions of the nodal forces by half-plane theory.

    Parameters
    ----------
    body : mesh with the boundary "contact" and at least one that is supported
    material : of the body
    datum_length : distance from a force at which a half-plane's surface counts as unmoved [length]

    Raises
    ------
    InputError
        For linear elements of a nearly incompressible body: they lock.
    ConvergenceError
        If the sparse solve leaves a residual above 1e-8, or rounding leaves no stiffness.
    """
    system = assemble(body, material)
    stiffness, residual = _interface_stiffness(system)
    try:
        compliance = _compliance(system, stiffness, material, datum_length)
    except LinAlgError as reason:
        raise ConvergenceError("condensation: a stiffness is lost in rounding, as of a block 1e6 times as high as wide") from reason
    asymmetry = float(np.abs(compliance - compliance.T).max() / np.abs(compliance).max())
    n, places = system.contact.shape[1], system.basis.doflocs[:, system.contact[0]]
    return CondensedBody(
        body,
        material,
        freeze(places[0]),
        freeze(places[1]),
        freeze(surface_weights(system.basis, system.contact)),
        freeze((compliance + compliance.T).reshape(2, n, 2, n) / 2),
        {"asymmetry": asymmetry, "residual": residual, "degrees_of_freedom": float(system.basis.N), "sparse_factorisations": 2.0},
    )


def displacement_fields(condensed: CondensedBody, forces: Array, datum_length: float) -> tuple[skfem.Basis, Array, Array]:
    """Displacement of the whole body under nodal contact forces, and the part of the mean stress that goes with r.

    Parameters
    ----------
    forces : (2, n, k) along x and outward on the contact nodes, k load cases [force per thickness]

    Returns
    -------
    basis : of the body
    displacements : (basis.N, k) [length]
    tension : (n_corners, k) r at the corners of the elements, added to every normal stress; zero for plain elements [stress]
    """
    system = assemble(condensed.body, condensed.material)
    cases = forces.reshape(-1, forces.shape[-1])
    load = np.zeros((system.stiffness.shape[0], forces.shape[-1]))
    load[system.contact.ravel()] = cases
    load[: system.basis.N] += _arc_work(system, condensed.material, datum_length)[0] @ cases
    # The ends of the arc hold a half-disc without a force, since the loads balance.
    free = np.setdiff1d(np.arange(len(load)), np.concatenate([system.held, system.arc[:, :1].ravel(), system.arc[1, -1:]]))
    displacements = np.zeros_like(load)
    displacements[free] = factorise(system.stiffness[free][:, free].tocsc()).solve(load[free])
    if system.arc.size:
        flat = condensed.compliance.reshape(len(cases), -1)
        displacements[: system.basis.N] += _rigid_part(system, flat @ cases - displacements[system.contact.ravel()])
    n_u, shear_modulus = system.basis.N, split_lame(condensed.material, condensed.order)[2]
    tension = np.zeros((system.basis.nodal_dofs.shape[1], forces.shape[-1]))
    if len(displacements) > n_u:
        tension[:] = shear_modulus * displacements[n_u:]
    return system.basis, displacements[:n_u], tension
