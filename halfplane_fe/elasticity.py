"""Plane-strain elasticity of one body, condensed to the nodes that may touch.

Displacement elements lock as nu -> 1/2: with quadratic ones the body's energy stays right, but the contact tractions rock from node
to node. So what Lame's lambda has above 2 G (nu = 1/3) enters through a continuous linear pressure r = lambda_1 div u, the pair of
Taylor and Hood, and nothing locks at any nu < 1/2; below that the elements are plain ones. Linear elements have no such partner.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse.linalg import SuperLU, splu
from skfem.helpers import div
from skfem.models.elasticity import lame_parameters, linear_elasticity

from halfplane_fe.far_field import arc_work, rigid_motions, surface_force_displacement
from meshes import BodyMesh
from scenes import ConvergenceError, Elastic, InputError, freeze

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Lame's lambda over the shear modulus above which the rest enters through a pressure of its own: nu = 1/3.
_PLAIN_LAMBDA = 2.0
# The largest nu of linear elements: they cost 2 % of the dissipation of the paper's cycle at 0.45, 7 % at 0.49, 20 % at 0.499.
_LARGEST_NU_LINEAR = 0.45


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
        return _order(self.body.mesh)


@dataclass(frozen=True, eq=False)
class _System:
    """The assembled body: stiffness, and which degrees of freedom are what; those after the `basis.N` of u are of r."""

    basis: skfem.Basis
    stiffness: sparse.csr_matrix
    contact: Indices  # (2, n) degrees of freedom (x, y) of the contact nodes, by ascending x
    around: tuple[str, ...]  # boundaries to the half-plane around the body; none for a body of finite size
    arc: Indices  # (2, m) the degrees of freedom there
    held: Indices  # those that supports keep at zero
    free: Indices  # all that neither follow nor are held


def _order(mesh: skfem.Mesh) -> int:
    return 2 if isinstance(mesh, (skfem.MeshTri2, skfem.MeshQuad2)) else 1


def scalar_element(mesh: skfem.Mesh, order: int) -> skfem.Element:
    """Lagrange element of order 1 or 2 on the mesh's triangles or quadrilaterals."""
    if mesh.refdom.nfacets == 3:
        return skfem.ElementTriP2() if order == 2 else skfem.ElementTriP1()
    return skfem.ElementQuad2() if order == 2 else skfem.ElementQuad1()


def _boundary_dofs(basis: skfem.Basis, name: str) -> Indices:
    """(2, n) degrees of freedom (x, y) of a named boundary, by ascending x, then y."""
    dofs = basis.get_dofs(name)
    components = [dofs.all([f"u^{component}"]) for component in ("1", "2")]
    places = basis.doflocs[:, components[0]]
    order = np.lexsort((places[1], places[0]))
    return np.array([np.asarray(one)[order] for one in components], dtype=np.int64)


def _assemble(body: BodyMesh, material: Elastic) -> _System:
    order = _order(body.mesh)
    if order == 1 and material.poisson_ratio > _LARGEST_NU_LINEAR:
        raise InputError(
            f"mesh: order = 1 with a Poisson ratio of {material.poisson_ratio:g} is refused: linear elements lock above "
            f"{_LARGEST_NU_LINEAR:g}; take order = 2"
        )
    basis = skfem.Basis(body.mesh, skfem.ElementVector(scalar_element(body.mesh, order)), intorder=2 * order)
    contact = _boundary_dofs(basis, "contact")
    around = tuple(name for name, support in body.supports.items() if support == "half_plane")
    arc = np.hstack([np.empty((2, 0), dtype=np.int64), *(_boundary_dofs(basis, name) for name in around)])
    held = _held(body, basis)
    stiffness = _stiffness(basis, material, order)
    free = np.setdiff1d(np.arange(stiffness.shape[0]), np.concatenate([arc.ravel(), held]))
    return _System(basis, stiffness, contact, around, arc, held, free)


def _held(body: BodyMesh, basis: skfem.Basis) -> Indices:
    """Degrees of freedom that the supports keep at zero."""
    components = {"fixed": (0, 1), "rollers": (1,), "guided": (0,), "half_plane": ()}
    held = [np.empty(0, dtype=np.int64)]
    for name, support in body.supports.items():
        dofs = _boundary_dofs(basis, name)
        held += [dofs[component] for component in components[support]]
        if support == "rollers" and "guided" not in body.supports.values():
            # Nothing else keeps the body from drifting along x; without a tangential load this support carries nothing.
            held.append(dofs[0, [np.argmin(np.abs(basis.doflocs[0, dofs[0]]))]])
    return np.unique(np.concatenate(held))


def split_lame(material: Elastic, order: int) -> tuple[float, float, float]:
    """Lame's lambda of the displacement elements, what of it goes through the pressure r (0 where nothing does), and G."""
    lam, shear_modulus = lame_parameters(material.young_modulus, material.poisson_ratio)
    rest = lam - _PLAIN_LAMBDA * shear_modulus
    return (lam - rest, rest, shear_modulus) if order == 2 and rest > 1e-6 * shear_modulus else (lam, 0.0, shear_modulus)


def _stiffness(basis: skfem.Basis, material: Elastic, order: int) -> sparse.csr_matrix:
    """Stiffness of u alone, or of (u, r/G) in the symmetric form [[K, G B^T], [G B, -G^2 M/lambda_1]]: quasi-definite."""
    # notation: G is the shear modulus
    lam, rest, G = split_lame(material, order)
    stiffness = linear_elasticity(lam, G).assemble(basis).tocsr()
    if not rest:
        return stiffness
    pressure = basis.with_element(scalar_element(basis.mesh, 1))
    divergence = skfem.BilinearForm(lambda u, r, _w: G * div(u) * r).assemble(basis, pressure)
    mass = skfem.BilinearForm(lambda r, s, _w: r * s).assemble(pressure)
    return sparse.bmat([[stiffness, divergence.T], [divergence, -(G**2) / rest * mass]]).tocsr()


def _surface_weights(basis: skfem.Basis, contact: Indices) -> Array:
    """Integral over the contact boundary of each contact node's shape function."""
    facets = skfem.FacetBasis(basis.mesh, basis.elem, facets=basis.mesh.boundaries["contact"], intorder=4)
    along_x = skfem.LinearForm(lambda v, w: v[0] + 0 * w.x[0])
    return np.asarray(along_x.assemble(facets))[contact[0]]


def _arc_displacement(system: _System, material: Elastic, datum_length: float, moments: int | None = None) -> Array:
    """(2 m, 2 n): displacement of the arc by unit forces on the contact nodes, half-plane theory."""
    places, forces = system.basis.doflocs[:, system.arc[0]], system.basis.doflocs[0, system.contact[0]]
    young, nu = material.young_modulus, material.poisson_ratio
    kernel = surface_force_displacement(places[0], places[1], forces, young, nu, datum_length, moments)
    return kernel.reshape(2 * places.shape[1], 2 * len(forces))


def _factorise(stiffness: sparse.csc_matrix, ordering: str = "MMD_AT_PLUS_A") -> SuperLU:
    # Symmetric positive definite: no pivoting, minimum degree on A + A^T (5 times faster here than the default order).
    return splu(stiffness, permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def _interface_stiffness(system: _System) -> tuple[Array, float]:
    """Stiffness of the contact and arc nodes (2 n + 2 m), all others eliminated, and its residual.

    The kept nodes stand last in the order of elimination, so that their stiffness is the trailing block of the factors: three to
    five times faster than solving for each unit force.
    """
    kept = np.concatenate([system.contact.ravel(), system.arc.ravel()])
    stiffness = system.stiffness
    inner = np.setdiff1d(system.free, system.contact.ravel())
    inner_factors = _factorise(stiffness[inner][:, inner].tocsc())
    order = np.concatenate([inner[np.argsort(inner_factors.perm_c)], kept])
    # A half-disc floats: stiffening the arc, eliminated last of all, keeps its pivots off zero.
    stiffer = np.zeros(stiffness.shape[0])
    stiffer[system.arc.ravel()] = stiffness.diagonal().max()
    factors = _factorise((stiffness + sparse.diags(stiffer))[order][:, order].tocsc(), "NATURAL")
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


def _compliance(system: _System, stiffness: Array, material: Elastic, datum_length: float) -> Array:
    """(2 n, 2 n): displacement of the contact nodes by unit forces on them; the arc carries the half-plane's tractions."""
    if not system.arc.size:
        return cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
    by_nodes, by_half_plane = _arc_work(system, material, datum_length)
    loads = np.vstack([np.eye(system.contact.size), by_nodes[system.arc.ravel()]])
    # The loads balance, so that holding the body in its three rigid motions changes nothing.
    rigid, _ = np.linalg.qr(rigid_motions(system.basis)[np.concatenate([system.contact.ravel(), system.arc.ravel()])])
    held = stiffness + np.abs(stiffness).max() * rigid @ rigid.T
    return loads.T @ cho_solve(cho_factor(held, overwrite_a=True), loads) - by_half_plane


def _arc_work(system: _System, material: Elastic, datum_length: float) -> tuple[Array, Array]:
    """See `far_field.arc_work`."""
    facets = np.concatenate([np.empty(0, dtype=np.int64), *(system.basis.mesh.boundaries[name] for name in system.around)])
    return arc_work(system.basis, facets, system.basis.doflocs[0, system.contact[0]], material, datum_length)


def _rigid_part(system: _System, displacement: Array) -> Array:
    """(basis.N, k): the rigid motion next to a displacement (2 n, k) of the contact nodes."""
    motions = rigid_motions(system.basis)
    return motions @ np.linalg.lstsq(motions[system.contact.ravel()], displacement, rcond=None)[0]


def truncated_compliance(body: BodyMesh, material: Elastic, datum_length: float, moments: int | None) -> Array:
    """(2, n, 2, n) compliance with the displacement of the first `moments` of the nodal forces prescribed on the arc: for studies.

    It is not made symmetric: the mean with its transpose would carry the error of the rigid shift, (a/L)^2, into the tractions.
    """
    system = _assemble(body, material)
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
    system = _assemble(body, material)
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
        freeze(_surface_weights(system.basis, system.contact)),
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
    system = _assemble(condensed.body, condensed.material)
    cases = forces.reshape(-1, forces.shape[-1])
    load = np.zeros((system.stiffness.shape[0], forces.shape[-1]))
    load[system.contact.ravel()] = cases
    load[: system.basis.N] += _arc_work(system, condensed.material, datum_length)[0] @ cases
    # The ends of the arc hold a half-disc without a force, since the loads balance.
    free = np.setdiff1d(np.arange(len(load)), np.concatenate([system.held, system.arc[:, :1].ravel(), system.arc[1, -1:]]))
    displacements = np.zeros_like(load)
    displacements[free] = _factorise(system.stiffness[free][:, free].tocsc()).solve(load[free])
    if system.arc.size:
        flat = condensed.compliance.reshape(len(cases), -1)
        displacements[: system.basis.N] += _rigid_part(system, flat @ cases - displacements[system.contact.ravel()])
    n_u, shear_modulus = system.basis.N, split_lame(condensed.material, condensed.order)[2]
    tension = np.zeros((system.basis.nodal_dofs.shape[1], forces.shape[-1]))
    if len(displacements) > n_u:
        tension[:] = shear_modulus * displacements[n_u:]
    return system.basis, displacements[:n_u], tension
