"""Static condensation: plane-strain elasticity of one body, reduced by a Schur complement to the
nodes that may touch.

The elements do not lock. Those of the displacement alone do as nu -> 1/2: with quadratic ones the
body's energy stays right, but the
contact tractions rock from node to node. So what Lame's lambda has above 2 G (nu = 1/3) enters
through a continuous linear pressure r = lambda_1 div u, the pair of Taylor and Hood, and nothing
locks at any nu < 1/2; below that the elements are plain ones. Linear elements have no such partner.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import skfem
from scipy import sparse
from scipy.linalg import LinAlgError, cho_solve, cholesky, qr
from scipy.linalg.lapack import dpotri
from scipy.sparse.linalg import SuperLU, splu
from skfem.models.elasticity import lame_parameters
from skfem.quadrature import get_quadrature

from halfplane_fe.far_field import arc_forces, line_elements
from meshes import BodyMesh
from scenes import ConvergenceError, Elastic, InputError, read_only_copy
from scenes.array_types import Array, Indices

# Lame's lambda over the shear modulus above which the rest enters through a pressure of its own: nu
# = 1/3.
PLAIN_LAMBDA = 2.0
# The largest nu of linear elements: they cost 2 % of the dissipation of the paper's cycle at 0.45,
# 7 % at 0.49, 20 % at 0.499.
_LARGEST_NU_LINEAR = 0.45


@dataclass(frozen=True, eq=False)
class System:
    """Finite-element system of one body: its degrees of freedom by what they do, and its stiffness.

    Those of u along x and y at node k are 2 k and 2 k + 1, as scikit-fem numbers them; after all of
    them come those of r/G at the corners, if there is a pressure r.

    Attributes
    ----------
    mesh, material
        of the body
    order
        of the elements, 1 or 2
    cells
        (n_elements, n) nodes of each element, see `cells_of`
    contact_dofs
        (2, n) degrees of freedom (x, y) of the contact nodes, by ascending x
    half_plane_arcs
        boundaries to the half-plane around the body; none for a body of finite size
    reaction_dofs
        degrees of freedom on which the known reactions to forces on the contact act: (2, m) along
        x and y of the nodes on those arcs; of a body on rollers, which its ends hold against Q,
        (1, m) along x of the nodes on its ends
    held_dofs
        those that supports keep at zero
    tension_forces
        (n_dofs,) forces of a unit of tension along x on the ends; zero of a body without ends
        [length]
    """

    mesh: skfem.Mesh
    material: Elastic
    order: int
    cells: Indices
    contact_dofs: Indices
    half_plane_arcs: tuple[str, ...]
    reaction_dofs: Indices
    held_dofs: Indices
    tension_forces: Array

    @cached_property
    def node_of_dof(self) -> Indices:
        """Node of each degree of freedom, (n_dofs,): of u_x and u_y in turn, then of the mixed
        pressure at the corners, where the elements have one.
        """
        nodes_of_displacements = np.repeat(np.arange(self.mesh.p.shape[1]), 2)
        if not split_lame(self.material, self.order).lambda_of_pressure:
            return nodes_of_displacements
        return np.concatenate([nodes_of_displacements, np.arange(self.mesh.nvertices)])

    @cached_property
    def basis(self) -> skfem.Basis:
        """Finite-element basis of the displacement u: two components of a Lagrange element of the
        mesh's order, 1 or 2.
        """
        return skfem.Basis(
            self.mesh,
            skfem.ElementVector(scalar_element(self.mesh, self.order)),
            intorder=2 * self.order,
        )

    @cached_property
    def stiffness(self) -> sparse.csr_matrix:
        """Stiffness matrix (n_dofs, n_dofs), assembled when it is first used [stress]."""
        return _stiffness(self, np.arange(len(self.cells)))


def order_of(mesh: skfem.Mesh) -> int:
    """Order of the elements of a mesh, 1 or 2."""
    return 2 if isinstance(mesh, (skfem.MeshTri2, skfem.MeshQuad2)) else 1


def scalar_element(mesh: skfem.Mesh, order: int) -> skfem.Element:
    """Lagrange element of order 1 or 2 on the mesh's triangles or quadrilaterals."""
    if mesh.refdom.nfacets == 3:
        return skfem.ElementTriP2() if order == 2 else skfem.ElementTriP1()
    return skfem.ElementQuad2() if order == 2 else skfem.ElementQuad1()


def cells_of(mesh: skfem.Mesh, order: int) -> Indices:
    """Node numbers of each element of a mesh, (n_elements, n): corners, then, of elements of order
    2, mid-side nodes, then the middle node of a quadrilateral.
    """
    # scikit-fem numbers the facets 01, 12, 02 of a triangle and 01, 12, 23, 03 of a quadrilateral,
    # as VTK does its mid-side nodes.
    n_corners = mesh.refdom.nfacets  # as many as sides
    rows = [mesh.t[:n_corners]]  # (nodes, n_elements)
    if order == 2:
        rows.append(mesh.nvertices + mesh.t2f)  # a node in the middle of each element side
    if order == 2 and n_corners == 4:
        # nodes in the middle of the elements have the last numbers
        rows.append(np.arange(mesh.p.shape[1] - mesh.nelements, mesh.p.shape[1])[None])
    return np.vstack(rows).T.astype(np.int64)


def _boundary_dofs(mesh: skfem.Mesh, order: int, name: str) -> Indices:
    """Degrees of freedom (2, n) along x and y of a named boundary, by ascending x, then y."""
    facets = mesh.boundaries[name]
    nodes_of_facets = [mesh.facets[:, facets].ravel()]
    if order == 2:
        nodes_of_facets.append(mesh.nvertices + facets)
    nodes = np.unique(np.concatenate(nodes_of_facets))
    nodes = nodes[np.lexsort((mesh.p[1, nodes], mesh.p[0, nodes]))].astype(np.int64)
    return np.stack([2 * nodes, 2 * nodes + 1])


def assemble(body: BodyMesh, material: Elastic) -> System:
    """Finite-element system of a meshed body on its supports.

    It states which degrees of freedom lie on the contact and on the arc of a half-disc (a
    half-plane's mesh), which are held, and the forces of a unit of tension on the body's ends.

    Parameters
    ----------
    body
        its `mesh`, and `supports`: name of a boundary -> "fixed" (no displacement), "rollers" (none
        along y), "guided" (none along x), "half_plane" (an arc with the half-plane around it) or
        "pulled" (an end under tension)
    material
        its elastic constants

    Raises
    ------
    InputError
        For linear elements of a nearly incompressible body, since they lock.
    """
    mesh = body.mesh
    order = order_of(mesh)
    supports = body.supports
    # _LARGEST_NU_LINEAR: largest Poisson's ratio of linear elements, 0.45
    if order == 1 and material.poisson_ratio > _LARGEST_NU_LINEAR:
        raise InputError(
            f"mesh: order = 1 with a Poisson ratio of {material.poisson_ratio:g} is refused: linear"
            f" elements lock above {_LARGEST_NU_LINEAR:g}; take order = 2"
        )

    # Degrees of freedom (2, n) along x and y of each boundary.
    boundary_dofs = {name: _boundary_dofs(mesh, order, name) for name in ("contact", *supports)}
    half_plane_arcs = tuple(name for name, support in supports.items() if support == "half_plane")
    pulled_ends = tuple(name for name, support in supports.items() if support == "pulled")

    # Where known reactions act: on arcs, or on the ends of a body on rollers without arcs, which
    # hold it against Q.
    reaction_dofs = np.hstack(
        [np.empty((2, 0), dtype=np.int64), *(boundary_dofs[name] for name in half_plane_arcs)]
    )
    if pulled_ends and supports["base"] == "rollers":
        reaction_dofs = np.hstack([boundary_dofs[name][:1] for name in pulled_ends])

    # The tension on the ends is added last, since its forces need the system.
    system = System(
        mesh=mesh,
        material=material,
        order=order,
        cells=cells_of(mesh, order),
        contact_dofs=boundary_dofs["contact"],
        half_plane_arcs=half_plane_arcs,
        reaction_dofs=reaction_dofs,
        held_dofs=_held_dofs(mesh, supports, boundary_dofs),
        tension_forces=np.empty(0),
    )
    facets_of_ends = [facet for name in pulled_ends for facet in mesh.boundaries[name]]
    return replace(system, tension_forces=_tension_forces(system, facets_of_ends))


# Components of the displacement that each kind of support holds: 0 along x, 1 along y.
_COMPONENTS_HELD: dict[str, tuple[int, ...]] = {
    "fixed": (0, 1),
    "rollers": (1,),
    "guided": (0,),
    "half_plane": (),
    "pulled": (),
}


def _held_dofs(
    mesh: skfem.Mesh, supports: Mapping[str, str], boundary_dofs: Mapping[str, Indices]
) -> Indices:
    """Degrees of freedom of a body that its supports keep at zero, in ascending order.

    Where rollers alone support it, nothing keeps the body from drifting along x. Then the middle
    node on the rollers is held along x too. This support carries nothing: there is no tangential
    load, or the ends hold the body.

    Parameters
    ----------
    mesh
        of the body; the degree of freedom along x of node k is number 2 k
    supports
        name of a boundary -> kind of its support: "fixed", "rollers", "guided", ...
    boundary_dofs
        name of a boundary -> its degrees of freedom (2, n) along x and y
    """
    held_dofs = [np.empty(0, dtype=np.int64)]
    for name, support in supports.items():
        # _COMPONENTS_HELD: by the kind of support, 0 where it holds u_x, 1 where it holds u_y
        held_dofs += [boundary_dofs[name][component] for component in _COMPONENTS_HELD[support]]
        if support == "rollers" and "guided" not in supports.values():
            dofs_along_x = boundary_dofs[name][0]
            index_of_middle = np.argmin(np.abs(mesh.p[0, dofs_along_x // 2]))
            held_dofs.append(dofs_along_x[[index_of_middle]])
    return np.unique(np.concatenate(held_dofs))


def _tension_forces(system: System, facets: list[int]) -> Array:
    """Nodal forces (n_dofs,) by a unit of tension along x on the ends of a body [length]; `facets`
    are the numbers of the element sides there, whose outward normals are along x.

    # notation: in the integral v test displacement, w.n outward normal of the element side
    """
    forces = np.zeros(len(system.node_of_dof))  # one entry for each degree of freedom
    if facets:
        ends = skfem.FacetBasis(system.mesh, system.basis.elem, facets=np.array(facets), intorder=4)
        forces[: ends.N] = skfem.LinearForm(lambda v, w: w.n[0] * v[0]).assemble(ends)
    return forces


class SplitLame(NamedTuple):
    """Lame's constants [stress]: the part of lambda that the displacement elements have, the part
    that enters through the mixed pressure r (0 where there is none), and G.
    """

    lambda_of_displacement: float
    lambda_of_pressure: float
    shear_modulus: float


def split_lame(material: Elastic, order: int) -> SplitLame:
    """Lame's constants of a material, lambda split between displacement and mixed pressure r: r
    takes what lambda has above 2 G, in elements of order 2 only.
    """
    lam, shear_modulus = lame_parameters(material.young_modulus, material.poisson_ratio)
    rest_of_lambda = lam - PLAIN_LAMBDA * shear_modulus
    if order == 2 and rest_of_lambda > 1e-6 * shear_modulus:
        return SplitLame(lam - rest_of_lambda, rest_of_lambda, shear_modulus)
    return SplitLame(lam, 0.0, shear_modulus)


def _stiffness(system: System, element_numbers: Indices) -> sparse.csr_matrix:
    """Plane-strain stiffness matrix of some elements of a body, (n_dofs, n_dofs) [stress].

    Unknowns are the displacement u and, in a nearly incompressible material, r/G with the mixed
    pressure r. With D_iajb the integral of d_a phi_i d_b phi_j over an element,

        K_iajb = lambda D_iajb + G (D_ibja + delta_ab sum_c D_icjc).

    With r the matrix is [[K, G B^T], [G B, -G^2 M/lambda_1]] in (u, r/G): symmetric,
    quasi-definite. `element_numbers` are those of the elements.

    # notation: phi_i shape functions; a, b, c directions x, y; lambda the part of Lame's first
    # constant that acts through u, lambda_1 the part that acts through r; G shear modulus;
    # B divergence, M mass matrix of r
    """
    mesh = system.mesh
    cells = system.cells[element_numbers]  # (n_elements, n_nodes) node numbers
    lame = split_lame(system.material, system.order)

    # Gradients of the shape functions (n_elements, 2 n_nodes, q) at q quadrature points, and the
    # area of each point.
    points, weights = get_quadrature(mesh.refdom, 2 * system.order)
    gradients, point_areas = _gradients_and_areas(mesh, cells, system.order, points, weights)

    # Matrix of each element: K, and in a nearly incompressible material the blocks of r/G at the
    # corners, G B (coupling) and -G^2 M/lambda_1.
    element_matrices = displacement_blocks = _displacement_matrices(gradients, point_areas, lame)
    dofs = (2 * cells[..., None] + [0, 1]).reshape(len(cells), -1)
    if lame.lambda_of_pressure:
        corners = cells[:, : mesh.refdom.nfacets]
        linear_element = scalar_element(mesh, 1)
        corner_shape_functions = np.stack(
            [linear_element.lbasis(points, i)[0] for i in range(corners.shape[1])]
        )
        coupling_blocks, mass_blocks = _pressure_matrices(
            gradients, point_areas, corner_shape_functions, lame
        )
        dofs = np.hstack([dofs, 2 * mesh.p.shape[1] + corners])
        element_matrices = np.block(
            [
                [displacement_blocks, coupling_blocks.transpose(0, 2, 1)],
                [coupling_blocks, mass_blocks],
            ]
        )

    # Entries of all elements are summed in a sparse matrix.
    rows = np.broadcast_to(dofs[:, :, None], element_matrices.shape)
    columns = np.broadcast_to(dofs[:, None, :], element_matrices.shape)
    entries = (element_matrices.ravel(), (rows.ravel(), columns.ravel()))
    return sparse.csr_matrix(entries, shape=(len(system.node_of_dof),) * 2)


def _displacement_matrices(gradients: Array, point_areas: Array, lame: SplitLame) -> Array:
    """Stiffness matrices of the displacement of elements, (n_elements, 2 n, 2 n) for n nodes of
    each [stress]. With D_iajb the integral of d_a phi_i d_b phi_j over an element they are

        K_iajb = lambda D_iajb + G (D_ibja + delta_ab sum_c D_icjc).

    # notation: phi_i shape functions; a, b, c directions x, y; lambda the part of Lame's first
    # constant that acts through the displacement; G shear modulus; in subscripts of einsum e
    # elements, i and j nodes, c directions

    Parameters
    ----------
    gradients
        (n_elements, 2 n, q) of the shape functions along x and y at q quadrature points [1/length]
    point_areas
        (n_elements, 1, q) area of each point
    lame
        Lame's constants; used are the part lambda of the displacement, and G
    """
    shear_modulus = lame.shear_modulus
    n_elements, n_dofs, _ = gradients.shape
    D = gradients * point_areas @ gradients.transpose(0, 2, 1)
    D = D.reshape(n_elements, n_dofs // 2, 2, n_dofs // 2, 2)
    matrices = lame.lambda_of_displacement * D + shear_modulus * D.swapaxes(2, 4)
    matrices[:, :, [0, 1], :, [0, 1]] += shear_modulus * np.einsum("eicjc->eij", D)
    return np.asarray(matrices.reshape(n_elements, n_dofs, -1))


def _pressure_matrices(
    gradients: Array, point_areas: Array, corner_shape_functions: Array, lame: SplitLame
) -> tuple[Array, Array]:
    """Blocks G B (n_elements, n_corners, 2 n) and -G^2 M/lambda_1 (n_elements, n_corners,
    n_corners) of the element matrices that the mixed pressure r adds, for n nodes and n_corners
    corners of each element. The unknowns are r/G at the corners, between which r is linear: hence
    the factors G and G^2.

    # notation: u displacement; r = lambda_1 div u; B matrix of div u, M mass matrix, both weighted
    # with the functions of r; lambda_1 the part of Lame's first constant that acts through r; G
    # shear modulus

    Parameters
    ----------
    gradients
        (n_elements, 2 n, q) of the shape functions of u along x and y at q quadrature points
        [1/length]
    point_areas
        (n_elements, 1, q) area of each point
    corner_shape_functions
        (n_corners, q) linear functions, each 1 at its corner and 0 at the others
    lame
        Lame's constants; used are the part lambda_1 of the pressure, and G
    """
    shear_modulus = lame.shear_modulus
    weighted_shape_functions = corner_shape_functions * point_areas
    coupling_blocks = shear_modulus * weighted_shape_functions @ gradients.transpose(0, 2, 1)
    mass_blocks = (
        -(shear_modulus**2)
        / lame.lambda_of_pressure
        * weighted_shape_functions
        @ corner_shape_functions.T
    )
    return coupling_blocks, mass_blocks


def _gradients_and_areas(
    mesh: skfem.Mesh, cells: Indices, order: int, points: Array, weights: Array
) -> tuple[Array, Array]:
    """Gradients along x and y of the n shape functions of elements at q quadrature points,
    (n_elements, 2 n, q) [1/length], and the area of each point, (n_elements, 1, q).

    Parameters
    ----------
    mesh
        of the body: its `p` (2, n_nodes) are places of nodes [length]
    cells
        (n_elements, n) nodes of the elements
    order
        of the elements, 1 or 2
    points, weights
        (2, q) and (q,) quadrature rule on the reference element

    # notation: in subscripts of einsum e elements, n their nodes, q quadrature points, a and b
    # directions; xx, xy, yx, yy entries of the Jacobian
    """
    element = scalar_element(mesh, order)  # Lagrange element; lbasis: shape function and gradient
    reference_gradients = np.stack(  # (n, 2, q)
        [element.lbasis(points, i)[1] for i in range(cells.shape[1])]
    )
    jacobian = np.einsum("aen,nbq->abeq", mesh.p[:, cells], reference_gradients, optimize=True)
    (xx, xy), (yx, yy) = jacobian
    determinant = xx * yy - xy * yx
    inverse_jacobian = np.array([[yy, -xy], [-yx, xx]]) / determinant
    gradients = np.einsum("nbq,baeq->enaq", reference_gradients, inverse_jacobian)
    point_areas = (np.abs(determinant) * weights)[:, None]
    return gradients.reshape(len(cells), -1, len(weights)), point_areas


# How far a compliance may be from the solution of its mesh under a random load. Rounding leaves
# 1e-13; of a guided block 1e4 times as high as wide 4e-8. With 1e-7 (free sides, 1e2 times as high)
# the contact iterations end nowhere.
_LARGEST_ERROR = 1e-6


@dataclass(frozen=True, eq=False)
class CondensedBody:
    """Compliance of a body at its contact nodes, all others eliminated (static condensation).

    Attributes
    ----------
    body, material
        what was condensed
    x, y
        (n,) places of the contact nodes in ascending order of x; y = 0 on a flat face [length]
    face_lengths
        (n,) integral of each node's shape function over the surface [length]
    compliance
        (2, n, 2, n) displacement (along x, outward) of node i by a unit force (along x,
        outward) on node j, symmetric [length per force per thickness]
    displacement_by_stress
        (2, n) displacement (along x, outward) of the contact nodes by a unit of bulk stress
        [length per stress]: of a half-plane (x, -nu/(1 - nu) y) (1 - nu^2)/E, exactly; of a
        body with ends that of the mesh under tension on both; zeros for any other
    diagnostics
        asymmetry (largest skew part over largest entry: rounding), residual (see `condense`),
        degrees_of_freedom, sparse_factorisations (one for the order of elimination, one for
        each subspace)
    """

    body: BodyMesh
    material: Elastic
    x: Array
    y: Array
    face_lengths: Array
    compliance: Array
    displacement_by_stress: Array
    diagnostics: Mapping[str, float]

    @property
    def order(self) -> int:
        """Order of the body's elements, 1 or 2."""
        return order_of(self.body.mesh)


def factorise(stiffness: sparse.csc_matrix, ordering: str = "MMD_AT_PLUS_A") -> SuperLU:
    """Sparse LU factors of a stiffness that is symmetric, positive or quasi-definite [stress]: no
    pivoting, rows and columns in the order that `ordering` names to SuperLU.
    """
    # Minimum degree on A + A^T is 5 times faster here than the default order.
    return splu(
        stiffness, permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


class _Subspace(NamedTuple):
    """Displacements of a body that are condensed by themselves, spanned by k orthonormal motions:
    symmetric or antisymmetric ones of a body that is its own mirror image, else all.

    With amplitudes a (k,) the displacement is u[dof] = factor_of_dof[dof] a[column_of_dof[dof]].

    Attributes
    ----------
    leading_dofs
        (k,) degree of freedom that each motion moves, together with its mirror image
    column_of_dof, factor_of_dof
        (n_dofs,) motion that moves each degree of freedom, and by how much; 0 if it is at rest
    """

    leading_dofs: Indices
    column_of_dof: Indices
    factor_of_dof: Array

    def motions(self, moved_dofs: Indices, motion_numbers: Indices) -> sparse.csr_matrix:
        """Displacement (m, n) of m degrees of freedom of the body in n of the k motions that span
        a subspace of its displacements.

        A degree of freedom is moved by one motion, `column_of_dof`, by the factor `factor_of_dof`.

        Parameters
        ----------
        moved_dofs
            (m,) numbers of the degrees of freedom
        motion_numbers
            (n,) numbers of the motions among the k
        """
        # Position of each motion among the n; -1 of all others. Each row has one entry, perhaps 0.
        position_of_motion = np.full(len(self.leading_dofs), -1)
        position_of_motion[motion_numbers] = np.arange(len(motion_numbers))
        column_of_row = position_of_motion[self.column_of_dof[moved_dofs]]
        factor_of_row = np.where(column_of_row >= 0, self.factor_of_dof[moved_dofs], 0.0)
        return sparse.csr_matrix(
            (factor_of_row, np.maximum(column_of_row, 0), np.arange(len(moved_dofs) + 1)),
            shape=(len(moved_dofs), len(motion_numbers)),
        )


def _symmetry_subspaces(system: System) -> tuple[Indices, tuple[_Subspace, ...]]:
    """Symmetric and antisymmetric displacements of a mirror-symmetric body. They have no elastic
    energy in common, so that each subspace can be condensed by itself on one half.

    Symmetric: u_x is odd in x, u_y and the unknown r/G (r the mixed pressure) are even;
    antisymmetric: the other way round. The stiffness in each is twice that of the half x >= 0. A
    subspace is spanned by motions: each displaces one degree of freedom together with its mirror
    image, by factors +-sqrt(1/2), or one at x = 0 alone, by 1.

    Returns
    -------
    element_numbers, subspaces
        Numbers of the elements at x >= 0, and the two subspaces. Of a body that is not its own
        mirror image to the last bit: all elements, and one subspace of all displacements.
    """
    mesh = system.mesh
    all_dofs = np.arange(len(system.node_of_dof))  # numbers of the degrees of freedom
    mirror_images = _mirror_images(system)  # number of the one at (-x, y) for each; or None
    right_elements = np.flatnonzero((mesh.p[0, mesh.t] >= 0).all(axis=0))
    if mirror_images is None or 2 * len(right_elements) != mesh.nelements:
        return np.arange(mesh.nelements), (_Subspace(all_dofs, all_dofs, np.ones(len(all_dofs))),)

    # Sign of each unknown's mirror image over its own: -1 for u_x if symmetric, else 1.
    is_on_right = mesh.p[0, system.node_of_dof] >= 0
    signs_if_symmetric = np.ones(len(all_dofs))
    signs_if_symmetric[: 2 * mesh.p.shape[1] : 2] = -1.0  # u_x
    subspaces = []
    for image_signs in (signs_if_symmetric, -signs_if_symmetric):
        pair_factors = np.sqrt(0.5) * np.where(is_on_right, 1.0, image_signs)
        factor_of_dof = np.where(mirror_images == all_dofs, (1 + image_signs) / 2, pair_factors)
        leading_dofs = np.flatnonzero(
            is_on_right & (factor_of_dof != 0)
        )  # those of x < 0 follow them
        column_of_dof = np.zeros_like(all_dofs)
        column_of_dof[leading_dofs] = np.arange(len(leading_dofs))
        column_of_dof[mirror_images[leading_dofs]] = np.arange(len(leading_dofs))
        subspaces.append(_Subspace(leading_dofs, column_of_dof, factor_of_dof))
    return right_elements, tuple(subspaces)


def _mirror_images(system: System) -> Indices | None:
    """Number of the degree of freedom at (-x, y) for each one at (x, y), (n_dofs,).

    None where nodes, elements or supports of the mesh are not mirror images to the last bit. It
    needs of the `system` the mesh, the nodes of its elements (`cells`), and the degrees of freedom
    that belong to the contact, to reactions and to supports.
    """
    # Nodes in order of x and in order of -x are mirror images of each other.
    places = system.mesh.p  # (2, n_nodes)
    nodes_left_to_right = np.lexsort((places[1], places[0]))
    nodes_right_to_left = np.lexsort((places[1], -places[0]))
    if not np.array_equal(
        places[:, nodes_left_to_right] * [[-1.0], [1.0]], places[:, nodes_right_to_left]
    ):
        return None
    images_of_nodes = np.empty_like(nodes_left_to_right)
    images_of_nodes[nodes_left_to_right] = nodes_right_to_left

    # Degrees of freedom: u_x and u_y of each node in turn, then r/G, r the mixed pressure, at the
    # corners where the elements have it.
    images_of_displacements = (2 * images_of_nodes[:, None] + [0, 1]).ravel()
    images_of_pressure_unknowns = 2 * len(images_of_nodes) + images_of_nodes
    images = np.concatenate([images_of_displacements, images_of_pressure_unknowns])[
        : len(system.node_of_dof)
    ]

    def sorted_columns(numbers: Indices) -> Indices:
        """Columns of a table of numbers, each sorted, the columns in lexicographic order."""
        sorted_numbers = np.sort(numbers, axis=0)
        return sorted_numbers[:, np.lexsort(sorted_numbers)]

    # Elements, contact, reactions and supports must have mirror images among themselves.
    for dofs in (
        2 * system.cells.T,  # u_x of the nodes of each element
        system.contact_dofs,
        system.reaction_dofs,
        system.held_dofs[None],
    ):
        if not np.array_equal(sorted_columns(dofs), sorted_columns(images[dofs])):
            return None
    return images


def _elimination_ranks(system: System, stiffness: sparse.csr_matrix) -> Indices:
    """Rank (n_dofs,) of each degree of freedom in an order of elimination that leaves the factors
    of a stiffness sparse. Those of one node have one rank.

    It is the minimum-degree order of the inner nodes, those that carry neither contact forces nor
    reactions, by their stiffness along x alone. This takes a quarter of the work of ordering all
    degrees of freedom. All other nodes have the last rank.

    It needs of the `system` the mesh, the degrees of freedom of contact and reactions along x (row
    0), and the node of each degree of freedom. That along x of node k is number 2 k.
    """
    n_nodes = system.mesh.p.shape[1]
    # Half of a mirror-symmetric body has no stiffness at the nodes of the other half.
    stiff_nodes = np.flatnonzero(stiffness.diagonal()[: 2 * n_nodes : 2])
    remaining_dofs = np.concatenate([system.contact_dofs[0], system.reaction_dofs[0]])
    inner_nodes = stiff_nodes[~np.isin(2 * stiff_nodes, remaining_dofs)]
    # The mixed pressure r of contact nodes has the last rank too: ranked first, it would fill the
    # factors.
    rank_of_node = np.full(n_nodes, n_nodes)
    if len(inner_nodes):
        # `perm_c` of the sparse factors is the rank of each row in the order of elimination.
        rank_of_node[inner_nodes] = factorise(
            stiffness[2 * inner_nodes][:, 2 * inner_nodes].tocsc()
        ).perm_c
    return rank_of_node[system.node_of_dof]


class _CondensedSubspace(NamedTuple):
    """A body's response to unit forces at its contact nodes, in one `_Subspace` of displacements.

    Attributes
    ----------
    motions
        (2 n, k) displacement of the n contact nodes (along x, then outward) in each of the k
        motions that move them
    compliance
        (k, k) amplitude of each of these motions by a unit force on each [1 / stress]
    amplitudes_by_tension
        (k,) amplitude of each of them by a unit of tension on the body's ends [length / stress]
    error
        of both: relative difference from the solution of the mesh under a random load
    """

    motions: sparse.csr_matrix
    compliance: Array
    amplitudes_by_tension: Array
    error: float


class _Elimination(NamedTuple):
    """A stiffness whose n_inner first degrees of freedom, the inner ones, are eliminated.

    Attributes
    ----------
    stiffness
        (n, n) symmetric, the inner degrees of freedom first
    n_inner
        number of the inner ones
    factors
        sparse factors of [K_ii 0; K_ti 1], i the inner ones, t the others
    schur_cholesky
        (t, t) lower Cholesky factor of the Schur complement K_tt - K_ti K_ii^-1 K_it
    """

    stiffness: sparse.csc_matrix
    n_inner: int
    factors: SuperLU
    schur_cholesky: Array

    @classmethod
    def from_stiffness(cls, stiffness: sparse.csc_matrix, n_inner: int) -> _Elimination:
        """Sparse elimination of the first n_inner degrees of freedom of a stiffness, and dense
        Cholesky factor of the Schur complement S of the others.

        With i the inner ones and t the others, SuperLU factorises

            [K_ii 0; K_ti 1] = L U,   L_ti = K_ti U_ii^-1,   S = K_tt - L_ti D L_ti^T,

        D being the diagonal of U. For S, which is dense, Cholesky is several times faster. Returned
        is a record of the stiffness, n_inner, these sparse factors and the Cholesky factor of S.
        """
        n_rows = stiffness.shape[0]
        remaining_dofs = slice(n_inner, None)
        unit_columns = sparse.eye_array(n_rows, n_rows - n_inner, k=-n_inner, format="csc")
        factors = factorise(
            sparse.hstack([stiffness[:, :n_inner], unit_columns], format="csc"), "NATURAL"
        )
        # L_ti D L_ti^T
        eliminated_stiffness = _weighted_outer_product(
            factors.L[remaining_dofs, :n_inner], factors.U.diagonal()[:n_inner]
        )
        schur_cholesky = cholesky(
            stiffness[remaining_dofs, remaining_dofs].toarray() - eliminated_stiffness, lower=True
        )
        return cls(stiffness, n_inner, factors, schur_cholesky)

    @property
    def inverse_of_schur(self) -> Array:
        """Displacement (t, t) of the t degrees of freedom that are not eliminated by unit forces on
        them: inverse of the Schur complement, from its Cholesky factor.
        """
        lower_triangle = np.tril(dpotri(self.schur_cholesky, lower=1)[0])
        return lower_triangle + np.tril(lower_triangle, -1).T

    def displacements(self, loads: Array) -> Array:
        """Displacement (n, k) of all degrees of freedom under `loads` (n, k), one column a case.

        The first `n_inner` degrees of freedom are eliminated. The others follow first, from the
        Cholesky factor of their Schur complement; then the eliminated ones, from sparse factors.
        """
        n_inner = self.n_inner
        remaining_dofs = slice(n_inner, None)
        # In the rows of the others this is their load minus what the eliminated ones take of it.
        displacements = self.factors.solve(loads)
        displacements[remaining_dofs] = cho_solve(
            (self.schur_cholesky, True), displacements[remaining_dofs]
        )
        displacements[:n_inner] -= self.factors.solve(
            self.stiffness[:, remaining_dofs] @ displacements[remaining_dofs]
        )[:n_inner]
        return displacements


def _condensed_subspace(
    system: System,
    subspace: _Subspace,
    stiffness: sparse.csr_matrix,
    ranks: Indices,
    half_plane_loads: ArcLoads,
) -> _CondensedSubspace:
    """Compliance of the contact nodes of a body in symmetric or in antisymmetric displacements, by
    static condensation, with an error estimate.

    The nodes of the arc of a half-disc stay with those of the contact, since the half-plane around
    it loads them. With B the forces on the arc by unit forces on the contact, and S the Schur
    complement of arc and contact, the compliance is [B; 1]^T S^-1 [B; 1]. From it the work of the
    tractions on the arc in the half-plane's own displacement is subtracted.

    # notation: [B; 1] B above the unit matrix

    Parameters
    ----------
    system
        the body's mesh, and its degrees of freedom: of the contact nodes (`contact_dofs`), of those
        with known reactions to the contact (`reaction_dofs`: arc of a half-disc, or ends of a body
        on rollers), of those that supports hold (`held_dofs`); forces by tension on its ends
    subspace
        its symmetric or antisymmetric displacements, or all, spanned by motions; `leading_dofs` is
        the degree of freedom that each motion moves, together with its mirror image
    stiffness
        of the whole system [stress]
    ranks
        (n_dofs,) place of each degree of freedom in an order of elimination that keeps factors
        sparse
    half_plane_loads
        by unit forces on the contact: nodal forces on the arc of a half-disc by the half-plane
        around it, and tractions and displacements of the half-plane at points of the arc, whose
        product is work

    Returns
    -------
    _CondensedSubspace
        Motions that move the contact nodes; amplitudes of these by unit forces (`compliance`) and
        by a unit of tension on the ends (`amplitudes_by_tension`); relative error of both.
    """
    # `subspace.motions(dofs, numbers)`: displacement of degrees of freedom in the motions of these
    # numbers. Here those of the whole body, in order of the numbers: inner ones, which are
    # eliminated, then those with reactions to the contact, then those of the contact.
    motion_numbers = _motion_numbers(system, subspace, ranks)
    ordered_motions = subspace.motions(
        np.arange(len(subspace.column_of_dof)), np.concatenate(motion_numbers)
    )
    ordered_stiffness = (ordered_motions.T @ stiffness @ ordered_motions).tocsc()
    elimination = _Elimination.from_stiffness(ordered_stiffness, len(motion_numbers.inner))

    # Unit loads on these motions: B and the work in the half-plane, by unit forces on the contact.
    contact_motions = subspace.motions(system.contact_dofs.ravel(), motion_numbers.contact)
    reaction_motions = subspace.motions(system.reaction_dofs.ravel(), motion_numbers.reaction)
    unit_loads = _SubspaceLoads(
        arc_loads=reaction_motions.T @ (half_plane_loads.nodal_forces @ contact_motions),
        tractions_on_arc=(half_plane_loads.tractions @ contact_motions).T,
        displacements_on_arc=half_plane_loads.displacements @ contact_motions,
        tension_on_ends=ordered_motions.T @ system.tension_forces,
    )
    compliance = _compliance_on_contact(elimination, unit_loads)
    amplitudes_by_tension, error = _tension_response_and_error(elimination, unit_loads, compliance)
    return _CondensedSubspace(contact_motions, compliance, amplitudes_by_tension, error)


class _MotionNumbers(NamedTuple):
    """Numbers of the motions of a `_Subspace` that are not held, in the order in which they are
    eliminated: inner ones, those with known reactions, and those of the contact.

    Attributes
    ----------
    inner
        (n_inner,) motions of nodes that carry neither contact forces nor reactions
    reaction
        (m,) motions of the nodes with known reactions: arc of a half-disc, or ends of a body on
        rollers
    contact
        (k,) motions of the contact nodes
    """

    inner: Indices
    reaction: Indices
    contact: Indices


def _motion_numbers(system: System, subspace: _Subspace, ranks: Indices) -> _MotionNumbers:
    """Numbers of the motions of a subspace that are not held: the inner ones by their rank in
    elimination, those with reactions, those of the contact.

    Motions of nodes that a support holds are left out, and on a half-disc as many of its arc as
    there are rigid motions in the subspace. The loads on it balance, so that holding these changes
    nothing.

    Parameters
    ----------
    system
        degrees of freedom of the contact, of reactions and of supports
    subspace
        `leading_dofs` is the degree of freedom that each motion moves, with its mirror image
    ranks
        (n_dofs,) place of each degree of freedom in an order of elimination that keeps factors
        sparse
    """
    contact_numbers = np.flatnonzero(np.isin(subspace.leading_dofs, system.contact_dofs))
    reaction_numbers = np.flatnonzero(np.isin(subspace.leading_dofs, system.reaction_dofs))
    held_numbers = np.flatnonzero(np.isin(subspace.leading_dofs, system.held_dofs))
    if system.half_plane_arcs:
        held_numbers, reaction_numbers = _held_on_arc(system, subspace, reaction_numbers)
    inner_numbers = np.delete(
        np.arange(len(subspace.leading_dofs)),
        np.concatenate([held_numbers, reaction_numbers, contact_numbers]),
    )
    inner_ranks = ranks[subspace.leading_dofs[inner_numbers]]
    return _MotionNumbers(
        inner_numbers[np.argsort(inner_ranks, kind="stable")], reaction_numbers, contact_numbers
    )


class _SubspaceLoads(NamedTuple):
    """Loads on a `_Subspace` of a body's displacements: by unit forces on the k motions that move
    its contact nodes, and by tension on its ends.

    Attributes
    ----------
    arc_loads
        (m, k) forces on the degrees of freedom of the arc by each unit force
    tractions_on_arc, displacements_on_arc
        (k, q) and (q, k), of the half-plane at points of the arc by each unit force; their product
        is work
    tension_on_ends
        (n,) forces on the motions that are not held, in the order of elimination, by a unit of
        tension along x on the ends [length]
    """

    arc_loads: Array
    tractions_on_arc: Array
    displacements_on_arc: Array
    tension_on_ends: Array


def _compliance_on_contact(elimination: _Elimination, unit_loads: _SubspaceLoads) -> Array:
    """Compliance (k, k) of the contact in one subspace: [B; 1]^T S^-1 [B; 1], minus the work of the
    half-plane's tractions on the arc in the half-plane's own displacement [1 / stress].

    # notation: B forces on the arc by unit forces on the contact (`arc_loads`); 1 unit matrix,
    # [B; 1] B above it; S Schur complement of arc and contact, in this order
    """
    n_arc = len(unit_loads.arc_loads)
    inverse_of_schur = elimination.inverse_of_schur
    displacement_by_forces = (
        inverse_of_schur[:, :n_arc] @ unit_loads.arc_loads + inverse_of_schur[:, n_arc:]
    )
    return np.asarray(
        unit_loads.arc_loads.T @ displacement_by_forces[:n_arc]
        + displacement_by_forces[n_arc:]
        - unit_loads.tractions_on_arc @ unit_loads.displacements_on_arc
    )


def _tension_response_and_error(
    elimination: _Elimination, unit_loads: _SubspaceLoads, compliance: Array
) -> tuple[Array, float]:
    """Displacement (k,) of the contact by a unit of tension on the ends of a body, and the relative
    error of the `compliance` (k, k): the largest of four relative errors.

    - Residual of the mesh's equations under random forces on the contact.
    - Residual of these equations under tension on the ends.
    - Displacement by the compliance against that of the mesh, under the random forces.
    - Reciprocity of both loads: each does the same work in the displacement by the other (Betti).

    As in the compliance, the half-plane's tractions on the arc count: their work is subtracted.

    Parameters
    ----------
    elimination
        factorised stiffness of the mesh; its first `n_inner` degrees of freedom are eliminated,
        then come those of the arc of a half-disc, then the k of the contact
    unit_loads
        `arc_loads` (m, k) on the arc by unit forces on the contact; tractions and displacements of
        the half-plane at points of the arc by them; forces by a unit of tension on the ends
    compliance
        (k, k) displacement of the contact by unit forces on it
    """
    # Two loads: random forces on the contact with their reactions on the arc, and tension.
    n_inner = elimination.n_inner
    n_arc, n_contact = unit_loads.arc_loads.shape
    random_forces = np.random.default_rng(0).standard_normal(n_contact)
    test_loads = np.zeros((elimination.stiffness.shape[0], 2))
    test_loads[n_inner:, 0] = np.concatenate([unit_loads.arc_loads @ random_forces, random_forces])
    test_loads[:, 1] = unit_loads.tension_on_ends
    solutions_of_tests = elimination.displacements(test_loads)
    displacement_by_random_forces, displacement_by_tension = (
        unit_loads.arc_loads.T @ solutions_of_tests[n_inner : n_inner + n_arc]
        + solutions_of_tests[n_inner + n_arc :]
    ).T
    displacement_by_random_forces = displacement_by_random_forces - unit_loads.tractions_on_arc @ (
        unit_loads.displacements_on_arc @ random_forces
    )

    # Residuals over the largest load, and the compliance against the displacement of the mesh.
    largest_loads = np.maximum(np.abs(test_loads).max(axis=0), 1e-300)
    residual_forces = elimination.stiffness @ solutions_of_tests - test_loads
    residuals = np.abs(residual_forces).max(axis=0) / largest_loads
    error_of_compliance = np.abs(compliance @ random_forces - displacement_by_random_forces).max()

    # Betti's theorem: the load does the work in the displacement by tension that the tension does
    # in its own.
    error_of_work = np.abs(
        random_forces @ displacement_by_tension - test_loads[:, 1] @ solutions_of_tests[:, 0]
    )
    scale_of_work = max(
        np.linalg.norm(random_forces) * np.linalg.norm(displacement_by_tension), 1e-300
    )
    errors = [
        *residuals,
        error_of_compliance / np.abs(displacement_by_random_forces).max(),
        error_of_work / scale_of_work,
    ]
    return displacement_by_tension, float(np.max(errors))


def _held_on_arc(
    system: System, subspace: _Subspace, arc_numbers: Indices
) -> tuple[Indices, Indices]:
    """Split the motions of a subspace that move the arc of a half-disc into a few that are held at
    zero, against rigid motion, and the others, ascending. One is held for each rigid motion in the
    subspace.

    Pivoted QR of the rigid motions picks those that hold best.

    Parameters
    ----------
    system
        the mesh of the half-disc; its `reaction_dofs` are the degrees of freedom on the arc
    subspace
        symmetric or antisymmetric displacements of it, spanned by motions, each of a degree of
        freedom and its mirror image
    arc_numbers
        numbers of the motions in the subspace that move the arc

    Returns
    -------
    held_numbers, remaining_numbers
        The two parts of `arc_numbers`.
    """
    all_arc_dofs = system.reaction_dofs.ravel()
    # Part of each motion in the two translations and the rotation, (n_arc_numbers, 3).
    rigid_motions_in_subspace = (
        subspace.motions(all_arc_dofs, arc_numbers).T @ rigid_motions(system.mesh)[all_arc_dofs]
    )
    _, triangular_factor, pivots = qr(rigid_motions_in_subspace.T, mode="economic", pivoting=True)
    n_rigid_motions = np.count_nonzero(
        np.abs(triangular_factor.diagonal()) > 1e-6 * np.abs(triangular_factor[0, 0])
    )
    return arc_numbers[pivots[:n_rigid_motions]], np.sort(arc_numbers[pivots[n_rigid_motions:]])


# Share of the rows from which on a column of L_ti counts as a dense one: of the shares tried it
# took the least time on bodies of all sizes.
_SHARE_OF_DENSE_COLUMN = 1 / 12


def _weighted_outer_product(columns: sparse.csc_matrix, factor: Array) -> Array:
    """The product columns @ diag(factor) @ columns.T, (k, k), of sparse `columns` (k, n) and a
    diagonal `factor` (n,) of either sign.

    For speed, columns with entries in more than a twelfth of the rows are multiplied as dense ones,
    the others as sparse ones.
    """
    n_rows = columns.shape[0]
    product = np.zeros((n_rows, n_rows))
    column_counts = np.diff(columns.indptr)  # number of entries in each column
    # _SHARE_OF_DENSE_COLUMN: 1/12
    is_dense = column_counts > _SHARE_OF_DENSE_COLUMN * n_rows
    is_sparse = ~is_dense & (column_counts > 0)
    scaled_columns = columns.copy()
    scaled_columns.data *= np.repeat(np.sqrt(np.abs(factor)), column_counts)

    # Positive and negative factors apart: sqrt|factor| stands in both columns of each product.
    for sign_of_factor in np.unique(np.sign(factor)):
        has_sign = factor * sign_of_factor > 0
        sparse_columns = scaled_columns[:, has_sign & is_sparse]
        dense_columns = scaled_columns[:, has_sign & is_dense].toarray()
        sparse_product = (sparse_columns @ sparse_columns.T).toarray()
        product += sign_of_factor * (sparse_product + dense_columns @ dense_columns.T)
    return product


class ArcLoads(NamedTuple):
    """Tractions that the half-plane around a half-disc exerts on its arc by unit forces on the n
    contact nodes, see `far_field.arc_forces`; for a body without an arc see `arc_loads`.

    Attributes
    ----------
    nodal_forces
        (2 m, 2 n) forces on the nodes of the arc, equal in work to the tractions
    tractions, displacements
        (k, 2 n) of the half-plane at points of the arc, whose product is their work in the
        half-plane's own displacement
    """

    nodal_forces: Array
    tractions: Array
    displacements: Array


def arc_loads(system: System, datum_length: float) -> ArcLoads:
    """Far-field loads that balance unit forces on the contact nodes: on the arc of a half-disc the
    tractions of the half-plane around it.

    On a body that rolls on its base and is held at its ends, the ends take a force along x in
    proportion to the nodal forces of a tension on them, and there are no points of an arc. For
    other bodies all arrays are empty.

    Parameters
    ----------
    system
        the body's mesh and material; its degrees of freedom on the contact (`contact_dofs`, x then
        y) and on the arc or ends (`reaction_dofs`); the boundaries that are arcs
        (`half_plane_arcs`); nodal forces by a unit of tension on its ends
    datum_length
        distance from a force at which the half-plane's surface has no displacement [length]

    Returns
    -------
    ArcLoads
        By unit forces on the contact nodes: forces on the nodes of arc or ends, then tractions and
        displacements of the half-plane at points of the arc.
    """
    # x of the contact nodes, and places (2, m) of those on the arc or ends
    contact_x = system.mesh.p[0, system.node_of_dof[system.contact_dofs[0]]]
    arc_places = system.mesh.p[:, system.node_of_dof[system.reaction_dofs[0]]]
    if system.half_plane_arcs:
        return ArcLoads(
            *arc_forces(arc_places, system.order, contact_x, system.material, datum_length)
        )
    nodal_forces = np.zeros((system.reaction_dofs.size, system.contact_dofs.size))
    if system.reaction_dofs.size:
        # In proportion to the nodal forces of tension: half on either end.
        end_forces = np.abs(system.tension_forces[system.reaction_dofs.ravel()])
        nodal_forces[:, : len(contact_x)] = -(end_forces / end_forces.sum())[:, None]
    no_points = np.zeros((0, system.contact_dofs.size))  # of an arc
    return ArcLoads(nodal_forces, tractions=no_points, displacements=no_points)


def rigid_motions(mesh: skfem.Mesh) -> Array:
    """Displacement of all nodes, (2 n_nodes, 3), in two translations and a rotation of the mesh,
    the latter over the largest |x|; rows are u_x, u_y of each node in turn.
    """
    x, y = mesh.p
    ones = np.ones_like(x)
    zeros = np.zeros_like(x)
    largest_x = np.abs(x).max()
    u_x = [ones, zeros, -y / largest_x]  # in each of the three motions
    u_y = [zeros, ones, x / largest_x]
    return np.stack([u_x, u_y]).transpose(2, 0, 1).reshape(-1, 3)


def condense(body: BodyMesh, material: Elastic, datum_length: float) -> CondensedBody:
    """Compliance matrix of a body's contact nodes, from its finite-element mesh by static
    condensation: all other nodes are eliminated.

    With i the inner and c the contact nodes: stiffness S = K_cc - K_ci K_ii^-1 K_ic (Schur
    complement), compliance S^-1. A half-disc stands for a half-plane: its arc carries the tractions
    that the half-plane has there. A body that is its own mirror image is condensed on one half, for
    symmetric and for antisymmetric displacements.

    Parameters
    ----------
    body
        mesh with the boundary "contact" and at least one that is supported
    material
        Young's modulus and Poisson's ratio of the body
    datum_length
        distance from a force at which a half-plane's surface has no displacement [length]

    Raises
    ------
    InputError
        For linear elements of a nearly incompressible body: they lock.
    ConvergenceError
        If rounding leaves no stiffness, or a compliance that is not the solution of the mesh under
        a random load to 1e-6.

    Examples
    --------
    >>> from meshes import SurfaceGrading
    >>> width, height = np.array([-1.0, 1.0]), np.array([-3.0, 0.0])
    >>> block = skfem.MeshQuad.init_tensor(width, height)  # one element, 2 wide and 3 high
    >>> block = block.with_boundaries(
    ...     {"contact": lambda x: x[1] == 0, "base": lambda x: x[1] == -3}
    ... )
    >>> body = BodyMesh("block", block, SurfaceGrading(0.0, 1.0, 1.0, 1.0), {}, {"base": "rollers"})
    >>> condensed = condense(body, Elastic(young_modulus=2.0, poisson_ratio=0.0), 1.0)
    >>> shortening = condensed.compliance[1, :, 1] @ [1.0, 1.0]
    >>> shortening.round(12).tolist()  # stress 1 over E = 2, times 3
    [1.5, 1.5]
    """
    system = assemble(body, material)
    try:
        response = _contact_response(system, datum_length)
    except LinAlgError as reason:  # a Cholesky factor does not exist
        raise ConvergenceError(
            "condensation: a stiffness is lost in rounding, as of a block 1e6 times as high as wide"
        ) from reason
    # both relative: skew part of the compliance, and what the mesh's equations leave
    largest_error = max(response.asymmetry, response.residual)
    # _LARGEST_ERROR: 1e-6
    if not largest_error <= _LARGEST_ERROR:
        raise ConvergenceError(
            "condensation: rounding leaves a compliance that differs from that of the mesh by"
            f" {largest_error:.1e}: the body is too slender for its contact, or some of"
            " its elements are too thin"
        )

    # Places of the contact nodes (2, n), and their displacement by bulk stress.
    places = system.mesh.p[:, system.node_of_dof[system.contact_dofs[0]]]
    dof_dimensions = system.contact_dofs.shape
    displacement_by_stress = response.displacement_by_stress.reshape(dof_dimensions)
    if system.half_plane_arcs:
        displacement_by_stress = displacement_by_unit_stress(material, *places)
    return CondensedBody(
        body=body,
        material=material,
        x=read_only_copy(places[0]),
        y=read_only_copy(places[1]),
        face_lengths=read_only_copy(_face_lengths(places, system.order)),
        compliance=read_only_copy(response.compliance.reshape(*dof_dimensions, *dof_dimensions)),
        displacement_by_stress=read_only_copy(displacement_by_stress),
        diagnostics={
            "asymmetry": response.asymmetry,
            "residual": response.residual,
            "sparse_factorisations": 1.0 + response.n_subspaces,
            "degrees_of_freedom": float(2 * system.mesh.p.shape[1]),
        },
    )


def _face_lengths(places: Array, order: int) -> Array:
    """Length of face (n,) that each contact node stands for: the integral of its shape function
    along the face. `places` (2, n) are x and y of the nodes, `order` is that of the elements.
    """
    # of each surface element: nodes, shape functions, and tangents times weights at Gauss points
    nodes, shape_values, _, tangents = line_elements(places, order, 3)
    lengths = np.bincount(nodes.ravel(), (np.hypot(*tangents) @ shape_values.T).ravel())
    return np.asarray(lengths, dtype=float)


class _ContactResponse(NamedTuple):
    """Displacement of the n contact nodes of a body, 2 n degrees of freedom: along x of all nodes,
    then outward.

    Attributes
    ----------
    compliance
        (2 n, 2 n) by unit forces on them, symmetric [1 / stress]
    displacement_by_stress
        (2 n,) by a unit of tension on the ends of the body [length / stress]
    asymmetry
        largest skew part of a computed compliance over its largest entry
    residual
        relative error of the solution under a random load
    n_subspaces
        number of subspaces of the displacements that were condensed by themselves: 1 or 2
    """

    compliance: Array
    displacement_by_stress: Array
    asymmetry: float
    residual: float
    n_subspaces: int


def _contact_response(system: System, datum_length: float) -> _ContactResponse:
    """Compliance of the contact nodes of a body, and their displacement by tension on its ends, by
    static condensation; with errors of round-off.

    The displacements of a body that is its own mirror image are condensed in two subspaces,
    symmetric and antisymmetric ones. The stiffness in each is twice that of the right half.

    Parameters
    ----------
    system
        finite-element system of the body
    datum_length
        distance from a force at which a half-plane's surface has no displacement [length]

    Raises
    ------
    LinAlgError
        Where rounding leaves a stiffness that is not positive definite.
    """
    loads_on_arc = arc_loads(system, datum_length)  # of the half-plane around a half-disc
    element_numbers, subspaces = _symmetry_subspaces(system)
    stiffness = len(subspaces) * _stiffness(system, element_numbers)
    ranks = _elimination_ranks(system, stiffness)  # of the degrees of freedom, for sparse factors
    n_contact_dofs = system.contact_dofs.size
    compliance = np.zeros((n_contact_dofs, n_contact_dofs))
    displacement_by_stress = np.zeros(n_contact_dofs)
    asymmetry = 0.0
    residual = 0.0
    for subspace in subspaces:
        condensed_subspace = _condensed_subspace(system, subspace, stiffness, ranks, loads_on_arc)
        transpose = condensed_subspace.compliance.T
        relative_asymmetry = (condensed_subspace.compliance - transpose).max() / np.abs(
            condensed_subspace.compliance
        ).max()
        asymmetry = max(asymmetry, float(relative_asymmetry))
        residual = np.fmax(residual, condensed_subspace.error)
        symmetric_part = (condensed_subspace.compliance + transpose) / 2
        compliance += condensed_subspace.motions @ (condensed_subspace.motions @ symmetric_part).T
        displacement_by_stress += (
            condensed_subspace.motions @ condensed_subspace.amplitudes_by_tension
        )
    return _ContactResponse(
        compliance, displacement_by_stress, asymmetry, float(residual), len(subspaces)
    )


def displacement_by_unit_stress(material: Elastic, x: Array, y: Array) -> Array:
    """Displacement (2, n) along x and y of a half-plane at n places by a unit of uniform stress
    along x, in plane strain [length / stress]: ((1 - nu^2) x, -nu (1 + nu) y)/E.

    # notation: E Young's modulus, nu Poisson's ratio
    """
    E = material.young_modulus
    nu = material.poisson_ratio
    return np.stack([(1 - nu**2) / E * x, -nu * (1 + nu) / E * y])


def displacement_fields(
    condensed_body: CondensedBody, forces: Array, datum_length: float, stresses: Array | None = None
) -> tuple[skfem.Basis, Array, Array]:
    """Displacement of all nodes of a body under given forces on its contact nodes, by a solution of
    its full finite-element system.

    Mixed elements of nearly incompressible materials have a further unknown, returned too: the
    mixed pressure r = lambda_1 div u, a part of every normal stress. Lame's lambda is divided into
    two parts for this: 2 G, which acts through u, and the rest lambda_1, which acts through r.

    # notation: G shear modulus, u displacement

    Parameters
    ----------
    condensed_body
        the body: its mesh, material and contact nodes
    forces
        (2, n, k) along x and outward on the contact nodes, k load cases [force per thickness]
    datum_length
        distance from a force at which a half-plane's surface has no displacement [length]
    stresses
        (k,) bulk stress of the body [stress]; the uniform stretch of a half-plane by it is not
        in what is returned

    Returns
    -------
    basis
        finite-element basis of the displacement
    displacements
        (basis.N, k) values in this basis [length]
    mixed_pressure
        (n_corners, k) r at the corners of the elements, added to every normal stress; zero for
        plain elements [stress]
    """
    # `system` numbers the degrees of freedom; `balancing_loads` are those by unit forces on the
    # contact: of the half-plane around a half-disc on its arc, or on the ends of a block on rollers
    system = assemble(condensed_body.body, condensed_body.material)
    balancing_loads = arc_loads(system, datum_length)
    forces_on_contact = forces.reshape(-1, forces.shape[-1])

    # Forces on all degrees of freedom (n_dofs, k), with tension on the ends.
    forces_on_dofs = np.zeros((system.stiffness.shape[0], forces.shape[-1]))
    forces_on_dofs[system.contact_dofs.ravel()] = forces_on_contact
    forces_on_dofs[system.reaction_dofs.ravel()] += balancing_loads.nodal_forces @ forces_on_contact
    if stresses is not None:
        forces_on_dofs += system.tension_forces[:, None] * stresses

    # The unknowns: displacements of the nodes, then r/G at the corners of mixed elements.
    unknowns = _solved_unknowns(system, forces_on_dofs)
    n_displacements = system.basis.N
    displacements = unknowns[:n_displacements]
    pressures_over_g = unknowns[n_displacements:]
    if system.reaction_dofs.size:
        displacements += _missing_rigid_motion(
            system, balancing_loads, forces_on_contact, displacements
        )

    mixed_pressure = np.zeros((system.mesh.nvertices, forces.shape[-1]))
    if len(pressures_over_g):
        shear_modulus = split_lame(condensed_body.material, condensed_body.order).shear_modulus
        mixed_pressure[:] = shear_modulus * pressures_over_g
    return system.basis, displacements, mixed_pressure


def _solved_unknowns(system: System, nodal_forces: Array) -> Array:
    """Solution (n_dofs, k) of a body's finite-element system under k load cases: displacements of
    the nodes [length], then r/G at the corners of mixed elements.

    The degrees of freedom of the supports are held; of a half-disc also three at the ends of its
    arc, which take no force, since the loads balance.

    # notation: r mixed pressure of nearly incompressible materials, G shear modulus

    Parameters
    ----------
    system
        stiffness of the body, its degrees of freedom on supports and on the arc of a half-disc
    nodal_forces
        (n_dofs, k) [force per thickness]
    """
    held_dofs = system.held_dofs
    if system.half_plane_arcs:
        left_x_dof, left_y_dof = system.reaction_dofs[:, 0]
        right_y_dof = system.reaction_dofs[1, -1]
        end_dofs = [left_x_dof, left_y_dof, right_y_dof]
        held_dofs = np.concatenate([held_dofs, end_dofs])
    free_dofs = np.setdiff1d(np.arange(len(nodal_forces)), held_dofs)
    unknowns = np.zeros_like(nodal_forces)
    unknowns[free_dofs] = factorise(system.stiffness[free_dofs][:, free_dofs].tocsc()).solve(
        nodal_forces[free_dofs]
    )
    return unknowns


def _missing_rigid_motion(
    system: System, balancing_loads: ArcLoads, forces_on_contact: Array, displacements: Array
) -> Array:
    """Rigid motion (2 n_nodes, k) that a solution lacks since some nodes of its arc or ends were
    held: displacement of all nodes in k load cases [length].

    By Betti's theorem it moves each contact node by the work of the arc's loads under a unit force
    there, minus that in the half-plane.

    Parameters
    ----------
    system
        the mesh, and its degrees of freedom on the contact and on arc or ends
    balancing_loads
        forces on arc or ends by unit forces on the contact; tractions and displacements of the
        half-plane at points of the arc
    forces_on_contact
        (2 n, k) forces on the n contact nodes [force per thickness]
    displacements
        (2 n_nodes, k) of all nodes, as solved with the nodes held [length]
    """
    work_on_arc = balancing_loads.nodal_forces.T @ displacements[system.reaction_dofs.ravel()]
    work_in_half_plane = balancing_loads.tractions.T @ (
        balancing_loads.displacements @ forces_on_contact
    )
    missing_displacement = work_on_arc - work_in_half_plane
    unit_motions = rigid_motions(system.mesh)
    unit_motions_of_contact = unit_motions[system.contact_dofs.ravel()]
    amplitudes = np.linalg.lstsq(unit_motions_of_contact, missing_displacement, rcond=None)[0]
    return np.asarray(unit_motions @ amplitudes)
