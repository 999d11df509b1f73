"""A body's stiffness by plane-strain elements, and which of its degrees of freedom are what.

Displacement elements lock as nu -> 1/2: with quadratic ones the body's energy stays right, but the contact tractions rock from node
to node. So what Lame's lambda has above 2 G (nu = 1/3) enters through a continuous linear pressure r = lambda_1 div u, the pair of
Taylor and Hood, and nothing locks at any nu < 1/2; below that the elements are plain ones. Linear elements have no such partner.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse
from skfem.helpers import ddot, div, sym_grad
from skfem.models.elasticity import lame_parameters, linear_elasticity

from meshes import BodyMesh
from scenes import Elastic, InputError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Lame's lambda over the shear modulus above which the rest enters through a pressure of its own: nu = 1/3.
PLAIN_LAMBDA = 2.0
# The largest nu of linear elements: they cost 2 % of the dissipation of the paper's cycle at 0.45, 7 % at 0.49, 20 % at 0.499.
_LARGEST_NU_LINEAR = 0.45


@dataclass(frozen=True, eq=False)
class System:
    """A body's degrees of freedom, which of them are what, and its stiffness; those after the `basis.N` of u are of r/G.

    Attributes
    ----------
    basis : of the displacement u
    material : of the body
    order : of the elements, 1 or 2
    contact : (2, n) degrees of freedom (x, y) of the contact nodes, by ascending x
    around : boundaries to the half-plane around the body; none for a body of finite size
    arc : (2, m) the degrees of freedom there
    held : those that supports keep at zero
    """

    basis: skfem.Basis
    material: Elastic
    order: int
    contact: Indices
    around: tuple[str, ...]
    arc: Indices
    held: Indices

    @property
    def n_dofs(self) -> int:
        """Number of all degrees of freedom."""
        return int(self.basis.N + (self.basis.mesh.nvertices if split_lame(self.material, self.order)[1] else 0))

    @property
    def free(self) -> Indices:
        """All that neither follow the half-plane nor are held."""
        return np.setdiff1d(np.arange(self.n_dofs), np.concatenate([self.arc.ravel(), self.held]))

    @cached_property
    def stiffness(self) -> sparse.csr_matrix:
        """(n_dofs, n_dofs) assembled when it is first used [stress]."""
        return _stiffness(self.basis, self.material, self.order)

    def internal_forces(self, displacement: Array) -> Array:
        """(n_dofs,) stiffness times displacement, as the virtual work of the stress: no matrix, a tenth of its cost.

        Parameters
        ----------
        displacement : (n_dofs,) u [length], then r/G where the body has them
        """
        # notation: G is the shear modulus
        basis = self.basis
        lam, rest, G = split_lame(self.material, self.order)
        u = basis.interpolate(displacement[: basis.N])
        virtual_work = skfem.LinearForm(lambda v, w: lam * div(w["u"]) * div(v) + 2 * G * ddot(sym_grad(w["u"]), sym_grad(v)))
        forces = np.asarray(virtual_work.assemble(basis, u=u))
        if not rest:
            return forces
        pressure = basis.with_element(scalar_element(basis.mesh, 1))
        r = pressure.interpolate(displacement[basis.N :])
        of_pressure = skfem.LinearForm(lambda v, w: G * w["r"] * div(v)).assemble(basis, r=r)
        dilatation = skfem.LinearForm(lambda s, w: (G * div(w["u"]) - G**2 / rest * w["r"]) * s).assemble(pressure, u=u, r=r)
        return np.concatenate([forces + of_pressure, dilatation])


def order_of(mesh: skfem.Mesh) -> int:
    """Order of its elements, 1 or 2."""
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


def assemble(body: BodyMesh, material: Elastic) -> System:
    """The body on its supports; InputError for linear elements of a nearly incompressible body, since they lock."""
    order = order_of(body.mesh)
    if order == 1 and material.poisson_ratio > _LARGEST_NU_LINEAR:
        raise InputError(
            f"mesh: order = 1 with a Poisson ratio of {material.poisson_ratio:g} is refused: linear elements lock above "
            f"{_LARGEST_NU_LINEAR:g}; take order = 2"
        )
    basis = skfem.Basis(body.mesh, skfem.ElementVector(scalar_element(body.mesh, order)), intorder=2 * order)
    contact = _boundary_dofs(basis, "contact")
    around = tuple(name for name, support in body.supports.items() if support == "half_plane")
    arc = np.hstack([np.empty((2, 0), dtype=np.int64), *(_boundary_dofs(basis, name) for name in around)])
    return System(basis, material, order, contact, around, arc, _held(body, basis))


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
    rest = lam - PLAIN_LAMBDA * shear_modulus
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


def surface_weights(basis: skfem.Basis, contact: Indices) -> Array:
    """Integral over the contact boundary of each contact node's shape function."""
    facets = skfem.FacetBasis(basis.mesh, basis.elem, facets=basis.mesh.boundaries["contact"], intorder=4)
    along_x = skfem.LinearForm(lambda v, w: v[0] + 0 * w.x[0])
    return np.asarray(along_x.assemble(facets))[contact[0]]
