r"""What a body of finite size adds to the compliance of a half-plane: the smooth remainder of its
Green's function, by one linear solve on a coarse mesh.

A force at the point s of the face displaces the body by Flamant's field u_F of a half-plane plus a
remainder u_R. All that is singular is in u_F. With t_F the tractions of u_F on a cut,

    div sigma(u_R) = 0,   u_R = -u_F on supports,   t(u_R) = -t_F on the rest of the outline

Nothing here is large at s: t_F vanishes on the flat face, and sides and base are as far away as the
body is large. So the elements need no refinement at the force, nor at the edges of a contact, and
no contact is solved. At the face u_R gives four kernels, of unit forces: P presses (against y,
which points out of the body), Q pulls along +x,

    k_nn(x, s)  displacement inwards at x by P at s       k_tt(x, s)  along x by Q
    k_tn(x, s)  along x by P                              k_nt(x, s)  outwards by Q

By Betti's theorem k_nn and k_tt are symmetric and k_tn(x, s) = -k_nt(s, x). A body whose mirror
line is x = 0, as all bodies of scenes have, has near x = s = 0

    k_nn = c_n + N (x^2 + s^2)/2 + N_11 x s + N_4 (x^4 + s^4)/24 + N_22 x^2 s^2
           + ...       k_tt likewise
    k_tn = e x - a s + ...

On a curved face the same solve holds, with the half-plane of the force below a horizontal line
through the true place of it. t_F is not 0 on the face then, but bounded: -(F e_r) kappa/pi at the
force on an arc of curvature kappa. The kernels count from Flamant's field on the flat face, so that
the change of each of its terms by the slope m = dy/dx of the chord from s to x is added::

    ln r          + ln(1 + m^2)/2           x z/r^2       - m/(1 + m^2)
    z^2/r^2       + m^2/(1 + m^2)           theta         + arctan m

Directions stay those of the frame: x and y, not the tangent.

What c_n and c_t are depends on the datum length L of the half-plane: u_F counts from no movement of
the surface at the distance L from the force, along the force.

`body_effects` takes these numbers of both bodies of a scene and adds them up with the signs of the
relative problem; see `scenes.BodyEffects`.

Source of u_F and t_F: Johnson, Contact Mechanics (1985), sections 2.2 and 2.3, see `far_field`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import skfem

from halfplane_fe.dundurs import dundurs
from halfplane_fe.elasticity import System, assemble, factorise
from halfplane_fe.far_field import (
    curve_elements,
    surface_force_displacement,
    surface_force_traction,
)
from halfplane_fe.path import has_bulk_stress
from halfplane_fe.supports import bodies_are_alike
from meshes import BodyMesh, MeshSettings, Solid, SurfaceGrading, build
from scenes import (
    Block,
    BodyEffects,
    Elastic,
    Estimate,
    HalfPlane,
    InputError,
    Profile,
    Scene,
    Shape,
    TShape,
    scene_of,
)
from scenes.array_types import Array, Indices

# Gauss points of a facet: Flamant's tractions are smooth over an element, which is shorter than its
# distance from the force.
_N_GAUSS_POINTS = 9
# The part of the face that the kernels are fitted on, |x| <= r: r over the distance of the nearest
# place where the face or the material below it ends. Terms that the polynomial lacks are then below
# 1e-4 of the numbers.
_FITTED_REACH = 0.3
# Forces stand at these places over r: what s^4 does is seen too. Forces at x < 0 would repeat them
# as mirror images.
_FORCE_PLACES = (0.0, 0.5, 1.0)
# Largest degree of the polynomials in x and s together.
_LARGEST_DEGREE = 8
# Elements on 0 <= x <= r, and growth of their size with the distance from there.
_N_ELEMENTS = 16
_SIZE_GROWTH = 0.1
# The second mesh, by which the first one's error is judged: elements twice as large, fitted on
# a part of the face 1.25 times as wide. The difference of the two also has the terms that the
# polynomials lack.
_FACTOR_OF_COARSE_MESH = 2.0
_FACTOR_OF_WIDER_FACE = 1.25


class RemainderKernels(NamedTuple):
    """Displacement of a body's face by unit forces on it, minus that of a half-plane.

    Attributes
    ----------
    x
        (n,) places on the face, in ascending order [length]
    x_of_forces
        (m,) places of the forces [length]
    inward_displacement_by_pressure, x_displacement_by_shear
        (n, m) k_nn, inwards by a pressing unit force, and k_tt, along +x by one along +x
        [1 / stress]
    x_displacement_by_pressure, outward_displacement_by_shear
        (n, m) k_tn, along +x by a pressing unit force, and k_nt, outwards by one along +x
        [1 / stress]
    unknowns
        degrees of freedom of the linear system, which is factorised once
    """

    x: Array
    x_of_forces: Array
    inward_displacement_by_pressure: Array
    x_displacement_by_shear: Array
    x_displacement_by_pressure: Array
    outward_displacement_by_shear: Array
    unknowns: int

    @property
    def reciprocity_difference(self) -> float:
        """Largest |k_tn(x, s) + k_nt(s, x)| of places x and s of forces: 0 in exact elasticity, by
        reciprocity [1 / stress].

        # notation: k_tn displacement along x by a pressing force, k_nt outwards by a force along x
        """
        nodes = np.abs(self.x[:, None] - self.x_of_forces).argmin(axis=0)
        mismatch = (
            self.x_displacement_by_pressure[nodes] + self.outward_displacement_by_shear[nodes].T
        )
        return float(np.abs(mismatch).max())


def remainder_kernels(
    body: BodyMesh, material: Elastic, x_of_forces: Array, datum_length: float
) -> RemainderKernels:
    """Displacement of a body's face by unit forces on it, minus that of a half-plane (Flamant), by
    one linear finite-element solution without contact.

    The difference is itself an elastic field without a force on the face: its displacement on the
    supports is minus the half-plane's, and so are its tractions on the rest of the outline. It is
    smooth, so that a coarse mesh is enough, without refinement at the force.

    Parameters
    ----------
    body
        a mesh of quadratic elements, with supports that hold it; "contact" is the part of the
        face that is read
    material
        Young's modulus and Poisson's ratio of the body; above a ratio of 1/3 the elements are
        mixed, so that they do not lock
    x_of_forces
        (m,) places of the forces on the face [length]; on a curved one the nodes of "contact"
        next to them
    datum_length
        L, distance from a force at which a half-plane's surface counts as unmoved [length]

    Returns
    -------
    RemainderKernels
        At the n nodes of "contact", by unit forces at the m places: of pressing forces and of
        forces along +x. On a curved face Flamant's field counts from a flat one at y = 0.
    """
    # Finite-element system, and places of the contact nodes and of the forces. `contact_dofs`
    # (2, n) are the degrees of freedom along x and y of the contact nodes.
    system = assemble(body, material)
    node_x, node_y = body.mesh.p[:, system.node_of_dof[system.contact_dofs[0]]]
    forces = _SurfaceForces(x_of_forces, np.zeros(len(x_of_forces)))
    if node_y.any():
        force_nodes = np.abs(node_x[:, None] - x_of_forces).argmin(axis=0)
        forces = _SurfaceForces(node_x[force_nodes], node_y[force_nodes])

    # Displacements of the contact nodes along x and outwards: (n, 2, m), second axis force along x
    # and outwards.
    displacements = _remainder_displacements(system, forces, datum_length)
    displacement_along_x, displacement_outwards = displacements[system.contact_dofs].reshape(
        2, -1, 2, len(x_of_forces)
    )
    kernels = RemainderKernels(
        x=node_x,
        x_of_forces=forces.x,
        # a pull moves the face out as far as a push moves it in
        inward_displacement_by_pressure=displacement_outwards[:, 1],
        x_displacement_by_shear=displacement_along_x[:, 0],
        x_displacement_by_pressure=-displacement_along_x[:, 1],
        outward_displacement_by_shear=displacement_outwards[:, 0],
        unknowns=len(system.node_of_dof) - len(system.held_dofs),
    )
    return _with_chord_slopes(kernels, node_y, forces.y, material) if node_y.any() else kernels


def _remainder_displacements(system: System, forces: _SurfaceForces, datum_length: float) -> Array:
    """Displacement (n_dofs, 2 m) of a body by unit forces at m places of its face, along x and then
    along y, minus that of a half-plane [1 / stress].

    Supports are displaced, and the outline loaded, by minus what the half-plane has there.

    Parameters
    ----------
    system
        finite-element system of the body. Its degrees of freedom are x and y of each node, then
        those of the mixed pressure, if there is one. Supports hold `held_dofs`; `node_of_dof` has
        an entry for each
    forces
        places of the unit forces
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    """
    n_dofs = len(system.node_of_dof)
    held_dofs = system.held_dofs
    free_dofs = np.setdiff1d(np.arange(n_dofs), held_dofs)
    nodal_loads = np.zeros((n_dofs, 2 * len(forces.x)))
    nodal_loads[: 2 * system.mesh.p.shape[1]] = -_forces_of_tractions(system, forces)
    displacements = np.zeros_like(nodal_loads)
    # Supports are displaced first, which loads the free degrees of freedom.
    displacements[held_dofs] = -_support_displacements(system, forces, datum_length)
    nodal_loads -= system.stiffness[:, held_dofs] @ displacements[held_dofs]
    factorisation = factorise(system.stiffness[free_dofs][:, free_dofs].tocsc())
    displacements[free_dofs] = factorisation.solve(nodal_loads[free_dofs])
    return displacements


class _SurfaceForces(NamedTuple):
    """Coordinates of the places of m forces on the face, (m,) each [length]."""

    x: Array
    y: Array


def _half_plane_field(
    field: Callable[[Array, Array, Array], Array], x: Array, y: Array, forces: _SurfaceForces
) -> Array:
    """Displacement or traction (2, n, 2, m) of a half-plane at n points by m unit forces, one at a
    time; the flat surface of the half-plane goes through the place of the force.

    The axes are component, point, component of the force, force. `field` returns such an array from
    x, y of the points and x of the forces, where all forces are on the surface y = 0. `x` and `y`
    (n,) are the points, `forces` the places of the forces [length].
    """
    if not forces.y.any():
        return field(x, y, forces.x)
    fields_of_forces = [
        field(x, y - force_y, np.array([force_x]))
        for force_x, force_y in zip(forces.x, forces.y, strict=True)
    ]
    return np.concatenate(fields_of_forces, axis=-1)


def _with_chord_slopes(
    kernels: RemainderKernels, y: Array, y_of_forces: Array, material: Elastic
) -> RemainderKernels:
    """Displacements of a curved face by unit forces, minus those of a half-plane at the same x of
    its flat surface y = 0.

    Adds the difference of the half-plane's displacement between the true place on the curved face
    and the place on the flat one. It depends on the slope of the chord from force to place only.

    Parameters
    ----------
    kernels
        displacements (n, m) at places x (n,) by unit forces at m places, minus those of a
        half-plane at the true places on the curved face
    y, y_of_forces
        (n,), (m,) y of the face at the places and at the forces, 0 or below [length]
    material
        of the body
    """
    # Slope of each chord; where the place is that of the force, the slope of the face.
    distance_to_force = kernels.x[:, None] - kernels.x_of_forces
    is_at_force = distance_to_force == 0
    chord_slope = (y[:, None] - y_of_forces) / np.where(is_at_force, 1.0, distance_to_force)
    face_slope = np.gradient(y, kernels.x, edge_order=2)
    slope = np.where(is_at_force, face_slope[:, None], chord_slope)

    kernels_of_chord = kernels_of_slope(slope, material)
    return kernels._replace(
        inward_displacement_by_pressure=kernels.inward_displacement_by_pressure
        + kernels_of_chord.inward_displacement_by_pressure,
        x_displacement_by_shear=kernels.x_displacement_by_shear
        + kernels_of_chord.x_displacement_by_shear,
        x_displacement_by_pressure=kernels.x_displacement_by_pressure
        + kernels_of_chord.x_displacement_by_pressure,
        outward_displacement_by_shear=kernels.outward_displacement_by_shear
        + kernels_of_chord.outward_displacement_by_shear,
    )


class KernelsOfSlope(NamedTuple):
    """Displacements of a half-plane by unit forces at the end of a sloping chord from the force,
    minus those at the same x on the flat surface; any shape, [1 / stress].

    Attributes
    ----------
    inward_displacement_by_pressure, x_displacement_by_shear
        inwards by a pressing force; along +x by a force along +x
    x_displacement_by_pressure, outward_displacement_by_shear
        along +x by a pressing force; outwards by a force along +x
    """

    inward_displacement_by_pressure: Array
    x_displacement_by_shear: Array
    x_displacement_by_pressure: Array
    outward_displacement_by_shear: Array


def kernels_of_slope(slope: Array, material: Elastic) -> KernelsOfSlope:
    """Displacements of a half-plane by unit forces (Flamant) at the end of a chord of slope m =
    dy/dx from the force, minus those at the same x on its flat surface [1 / stress].

    The four terms of Flamant's displacement differ by

        ln r   by ln(1 + m^2)/2        x z/r^2  by -m/(1 + m^2)
        z^2/r^2 by m^2/(1 + m^2)       theta    by arctan m

    The displacement inwards by a pressing force is -c [(1 + k) ln r - z^2/r^2], that along x by a
    force along x -c [(1 + k) ln r + z^2/r^2]; those across the force are c [+-x z/r^2 - k theta].

    # notation: r distance, theta = atan2(x, z) and z = -y (depth) of the chord's end from the
    # force; c = 1/(2 pi G), G shear modulus, nu Poisson's ratio, k = 1 - 2 nu
    """
    c = (1 + material.poisson_ratio) / (np.pi * material.young_modulus)
    k = 1 - 2 * material.poisson_ratio
    log_term = (1 + k) * np.log1p(slope**2) / 2
    depth_term = slope**2 / (1 + slope**2)
    cross_term = slope / (1 + slope**2)
    angle_term = k * np.arctan(slope)
    return KernelsOfSlope(
        inward_displacement_by_pressure=-c * (log_term - depth_term),
        x_displacement_by_shear=-c * (log_term + depth_term),
        x_displacement_by_pressure=-c * (cross_term + angle_term),
        outward_displacement_by_shear=c * (cross_term - angle_term),
    )


def _forces_of_tractions(system: System, forces: _SurfaceForces) -> Array:
    """Nodal forces (2 n_nodes, 2 m) on a body whose outline bears the tractions that a half-plane
    has along the same line, under m unit forces on its surface (Flamant).

    Rows are x and y of each node, columns the m unit forces along x, then along y. On a flat face
    the tractions are zero. The nodal forces do the same work as the tractions.

    Parameters
    ----------
    system
        the body: its mesh of quadratic elements, with named boundaries
    forces
        places x, y of the forces (m,) on the face; y = 0 of a flat one

    # notation: in subscripts of einsum g Gauss points, d directions, e element sides, m unit forces
    """
    mesh = system.mesh
    # On a curved face an even number of Gauss points: the middle one of an odd number is a node,
    # where a force may stand.
    # _N_GAUSS_POINTS: nine
    n_points = _N_GAUSS_POINTS + 1 if forces.y.any() else _N_GAUSS_POINTS
    loaded_facets = _loaded_facets(mesh, on_curved_face=bool(forces.y.any()))

    # e element sides on the outline, with g Gauss points: `places` (2, e, g) of these, `tangents`
    # (2, e, g) times the length that each stands for; `nodes` (e, 3) of the sides, and their shape
    # functions `shapes` (3, g).
    sides = curve_elements(mesh.p, _outline_nodes(mesh, loaded_facets), n_points)
    tangent_x, tangent_y = sides.weighted_tangents
    # outward, times the length that each Gauss point stands for
    normals_by_length = np.stack([tangent_y.ravel(), -tangent_x.ravel()])
    x, y = sides.places.reshape(2, -1)

    def traction(x_of_points: Array, y_of_points: Array, x_of_forces: Array) -> Array:
        """Tractions at points by unit forces on the surface, times the length that each point
        stands for.
        """
        return surface_force_traction(x_of_points, y_of_points, normals_by_length, x_of_forces)

    # At the Gauss points, by forces of both directions at all places: (2, e, g, 2 m).
    tractions = _half_plane_field(traction, x, y, forces).reshape(2, *tangent_x.shape, -1)

    # Consistent nodal forces: tractions times shape functions, one node of each side at a time.
    nodal_forces = np.zeros((mesh.p.shape[1], 2, tractions.shape[-1]))
    for nodes, shape_values in zip(sides.nodes.T, sides.shapes, strict=True):
        np.add.at(nodal_forces, nodes, np.einsum("g,degm->edm", shape_values, tractions))
    return nodal_forces.reshape(-1, tractions.shape[-1])


def _loaded_facets(mesh: skfem.Mesh, *, on_curved_face: bool) -> Indices:
    """Numbers of the element sides on the outline of a body that bear tractions under forces on its
    face: all, but on a flat face those of the face itself, "contact" and "free".
    """
    free_of_traction = () if on_curved_face else ("contact", "free")
    return np.concatenate(
        [facets for name, facets in mesh.boundaries.items() if name not in free_of_traction]
    )


def _outline_nodes(mesh: skfem.Mesh, facets: Indices) -> Indices:
    """Nodes of e element sides on the outline of a quadratic mesh, (e, 3): begin, mid-side node,
    end, ordered so that the body lies on the left. `facets` (e,) are the numbers of the sides.

    In the mesh `facets` lists the two corners of each side, `f2t` its elements, `t` the corners of
    each element, and `p` places; the mid-side node of side k is number `nvertices` + k.
    """
    start_vertices, end_vertices = mesh.facets[:, facets]
    inner_points = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1)
    side_vectors = mesh.p[:, end_vertices] - mesh.p[:, start_vertices]
    inward_vectors = inner_points - mesh.p[:, start_vertices]
    is_body_on_right = side_vectors[0] * inward_vectors[1] - side_vectors[1] * inward_vectors[0] < 0
    first_node = np.where(is_body_on_right, end_vertices, start_vertices)
    last_node = np.where(is_body_on_right, start_vertices, end_vertices)
    return np.stack([first_node, mesh.nvertices + facets, last_node], axis=1).astype(np.int64)


def _support_displacements(system: System, forces: _SurfaceForces, datum_length: float) -> Array:
    """Displacement of a half-plane at the places of a body's supports by m unit forces on its
    surface (Flamant): (n_held, 2 m) [1 / stress].

    Rows are held degrees of freedom, columns the m forces along x, then along y. `datum_length` is
    the distance from a force at which the half-plane's surface counts as unmoved [length].

    Parameters
    ----------
    system
        the body: mesh, material, and degrees of freedom that its supports hold (`held_dofs`); those
        along x are even, those along y odd
    forces
        places x, y of the forces (m,) on the face
    """
    material = system.material

    def displacement(x_of_points: Array, y_of_points: Array, x_of_forces: Array) -> Array:
        """Displacements at points by unit forces on the surface y = 0."""
        return surface_force_displacement(
            x_of_points,
            y_of_points,
            x_of_forces,
            material.young_modulus,
            material.poisson_ratio,
            datum_length,
        )

    x, y = system.mesh.p[:, system.node_of_dof[system.held_dofs]]
    component = system.held_dofs % 2  # x or y
    displacements = _half_plane_field(displacement, x, y, forces)
    # of each held degree of freedom
    held_displacements = displacements[component, np.arange(len(x))]
    return held_displacements.reshape(len(x), -1)


# ------------------------------------------------------------------------------ numbers of one body
@dataclass(frozen=True)
class BodyNumbers:
    """What the finite size of one body adds to a half-plane: first coefficients of the power series
    of its kernels, see the module. In its own frame: x along the face, y outward, first contact at
    the origin.

    Attributes
    ----------
    normal_compliance, tangential_compliance
        c_n, c_t, the constant terms of k_nn and k_tt [1 / stress]
    normal_curvature, tangential_curvature
        N, T, of (x^2 + s^2)/2 in k_nn and k_tt [1 / (stress length^2)]
    strain_under_pressure
        e, strain of the face along x by P = 1 [1 / (stress length)]
    slope_under_shear
        a, slope of the outward displacement by Q = 1 [1 / (stress length)]
    normal_fourth, tangential_fourth
        N_4, T_4, of (x^4 + s^4)/24 in k_nn and k_tt [1 / (stress length^4)]
    normal_mixed, tangential_mixed
        N_22, T_22, of x^2 s^2 in k_nn and k_tt [1 / (stress length^4)]
    unknowns, factorisations
        of the linear systems that were solved
    """

    normal_compliance: Estimate
    tangential_compliance: Estimate
    normal_curvature: Estimate
    tangential_curvature: Estimate
    strain_under_pressure: Estimate
    slope_under_shear: Estimate
    normal_fourth: Estimate
    tangential_fourth: Estimate
    normal_mixed: Estimate
    tangential_mixed: Estimate
    unknowns: int
    factorisations: int


class FaceSeries(NamedTuple):
    """The first coefficients of the kernels at x = s = 0, as in `BodyNumbers`, without errors."""

    normal_compliance: float
    tangential_compliance: float
    normal_curvature: float
    tangential_curvature: float
    strain_under_pressure: float
    slope_under_shear: float
    normal_fourth: float
    tangential_fourth: float
    normal_mixed: float
    tangential_mixed: float


_ZERO_ESTIMATE = Estimate(0.0)
OF_HALF_PLANE = BodyNumbers(
    **dict.fromkeys(FaceSeries._fields, _ZERO_ESTIMATE), unknowns=0, factorisations=0
)


def face_series(kernels: RemainderKernels, degree: int = _LARGEST_DEGREE) -> FaceSeries:
    """First coefficients of the power series in x and s of a body's kernels: the displacement at x
    by a unit force at s, minus that of a half-plane. The body is its own mirror image in x = 0.

    Polynomials up to a `degree` in x and s together are fitted by least squares:

        k_nn = c_n + N (x^2 + s^2)/2 + N_4 (x^4 + s^4)/24 + N_22 x^2 s^2 + ...   k_tt likewise
        k_tn = e x - a s + ...

    # notation: n normal, t tangential; first index displacement, second force; c_n normal and c_t
    # tangential compliance, N and T curvatures, e strain by pressure, a slope by shear; index 4
    # fourth order, 22 mixed

    Parameters
    ----------
    kernels
        displacements (n, m) at places x (n,) by unit forces at `x_of_forces` (m,): k_nn inwards by
        a pressing force, k_tt and k_tn along x, k_nt outwards
    degree
        largest i + j; 8 by default
    """
    # By exponents (i, j) of x and s over the half-length of the part of the face that is fitted.
    half_length = float(np.abs(kernels.x).max())
    direct_coefficients = _direct_coefficients(kernels, half_length, degree)
    cross_coefficients = _cross_coefficients(kernels, half_length, degree)

    # Those of the power series, in k_nn and in k_tt. A pair (0, 0) or (2, 2) gives its term twice,
    # hence a factor of 2.
    compliance = 2 * direct_coefficients[0, 0]
    curvature = 2 * direct_coefficients[0, 2] / half_length**2
    fourth_coefficients = 24 * direct_coefficients[0, 4] / half_length**4
    mixed_coefficients = 2 * direct_coefficients[2, 2] / half_length**4
    return FaceSeries(
        normal_compliance=float(compliance[0]),
        tangential_compliance=float(compliance[1]),
        normal_curvature=float(curvature[0]),
        tangential_curvature=float(curvature[1]),
        strain_under_pressure=cross_coefficients[1, 0] / half_length,
        slope_under_shear=-(cross_coefficients[0, 1] / half_length),
        normal_fourth=float(fourth_coefficients[0]),
        tangential_fourth=float(fourth_coefficients[1]),
        normal_mixed=float(mixed_coefficients[0]),
        tangential_mixed=float(mixed_coefficients[1]),
    )


def _direct_coefficients(
    kernels: RemainderKernels, half_length: float, degree: int
) -> dict[tuple[int, int], Array]:
    """Coefficients of the terms x^i s^j + x^j s^i, i <= j, of the displacements of a face in the
    direction of the force: by (i, j) those (2,) of k_nn and of k_tt, by least squares.

    Both are symmetric in x and s by reciprocity. They are even in x and s together, i + j even,
    since the body is its own mirror image. x and s are over `half_length`; i + j is at most
    `degree`.

    Parameters
    ----------
    kernels
        displacements (n, m) at places x (n,) by unit forces at s (m,), `x_of_forces`: k_nn inwards
        by a pressing force, k_tt along x by a force along x
    """
    unit_x, unit_s = np.meshgrid(
        kernels.x / half_length, kernels.x_of_forces / half_length, indexing="ij"
    )
    even_pairs = [(i, j) for i, j in even_exponents(degree) if i <= j]
    even_terms = np.stack(
        [(unit_x**i * unit_s**j + unit_x**j * unit_s**i).ravel() for i, j in even_pairs], axis=1
    )
    direct_kernels = np.stack(
        [kernels.inward_displacement_by_pressure.ravel(), kernels.x_displacement_by_shear.ravel()],
        axis=1,
    )
    coefficients = np.linalg.lstsq(even_terms, direct_kernels, rcond=None)[0]
    return dict(zip(even_pairs, coefficients, strict=True))


def _cross_coefficients(
    kernels: RemainderKernels, half_length: float, degree: int
) -> dict[tuple[int, int], float]:
    """Coefficients of the terms x^i s^j of the displacement k_tn of a face along x by a pressing
    force, by (i, j), with odd i + j up to `degree`, by least squares.

    By reciprocity k_tn(x, s) = -k_nt(s, x), k_nt being the displacement outwards by a force along
    x: both are fitted together. x and s are over `half_length`.

    Parameters
    ----------
    kernels
        displacements (n, m) at places x (n,) by unit forces at s (m,), `x_of_forces`
    """
    unit_x, unit_s = np.meshgrid(
        kernels.x / half_length, kernels.x_of_forces / half_length, indexing="ij"
    )
    odd_pairs = odd_exponents(degree)
    terms_by_pressure = np.stack([(unit_x**i * unit_s**j).ravel() for i, j in odd_pairs], axis=1)
    terms_by_shear = np.stack([(unit_s**i * unit_x**j).ravel() for i, j in odd_pairs], axis=1)
    odd_terms = np.concatenate([terms_by_pressure, terms_by_shear])
    cross_kernels = np.concatenate(
        [kernels.x_displacement_by_pressure.ravel(), -kernels.outward_displacement_by_shear.ravel()]
    )
    coefficients = np.linalg.lstsq(odd_terms, cross_kernels, rcond=None)[0]
    return dict(zip(odd_pairs, coefficients.tolist(), strict=True))


def even_exponents(degree: int) -> list[tuple[int, int]]:
    """Exponents (i, j) of all products x^i s^j with even sums i + j up to the degree."""
    return _exponents(range(0, degree + 1, 2))


def odd_exponents(degree: int) -> list[tuple[int, int]]:
    """Exponents (i, j) of all products x^i s^j with odd sums i + j below the degree."""
    return _exponents(range(1, degree, 2))


def _exponents(totals: Iterable[int]) -> list[tuple[int, int]]:
    """Exponents (i, j) of all products x^i s^j whose sum i + j is one of the `totals`."""
    exponents = []
    for total in totals:
        exponents += [(i, total - i) for i in range(total + 1)]
    return exponents


def face_kernels(
    name: str,
    shape: Solid,
    profile: Profile,
    material: Elastic,
    datum_length: float,
    size_factor: float = 1.0,
) -> RemainderKernels:
    """Mesh a body and compute the displacement of the middle of its face by unit forces there,
    minus that of a half-plane. The middle is |x| up to 0.3 of the distance to the nearest place
    where the body ends.

    Parameters
    ----------
    name
        "lower" or "upper"
    shape, profile, material
        the body, the profile of its face, its elastic constants
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    size_factor
        factor on the element size; above 1, for an estimate of the error, the part of the face on
        which the displacement is found is wider too
    """
    half_length = _FITTED_REACH * nearest_end(shape)
    if size_factor > 1:
        half_length *= _FACTOR_OF_WIDER_FACE  # 1.25
    # _N_ELEMENTS: 16 elements on half of that part of the face
    size = size_factor * half_length / _N_ELEMENTS  # of the elements on that part of the face
    grading = SurfaceGrading(inner=0.0, outer=half_length, size=size, edge_size=size)
    # _SIZE_GROWTH: growth of the element size per distance, 0.1
    body = build(name, shape, profile, grading, MeshSettings(growth=size_factor * _SIZE_GROWTH))
    # _FORCE_PLACES: 0, 0.5 and 1
    x_of_forces = half_length * np.array(_FORCE_PLACES)
    return remainder_kernels(body, material, x_of_forces, datum_length)


def body_numbers(
    name: str, shape: Solid, profile: Profile, material: Elastic, datum_length: float
) -> BodyNumbers:
    """Numbers by which the finite size of a body changes a contact: added compliances, curvatures
    of its face under load, strain by P and slope by Q, each with an uncertainty.

    The uncertainty is the difference from a coarser mesh. Strain by P and slope by Q follow from
    kernels that are equal by reciprocity (Betti): the largest difference of these, over the fitted
    half-length, is added to the uncertainties of both.

    Parameters
    ----------
    name
        "lower" or "upper"
    shape, profile, material
        the body, the profile of its face, its elastic constants
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    """
    # Kernels: displacement of the face by unit forces, minus that of a half-plane, on two meshes;
    # the elements of the second one are twice as large.
    kernels = face_kernels(name, shape, profile, material, datum_length)
    coarse_kernels = face_kernels(
        name, shape, profile, material, datum_length, _FACTOR_OF_COARSE_MESH
    )

    # Coefficients of their power series in the places of displacement and force.
    # `reciprocity_difference`: largest difference of the two kernels that are equal by reciprocity
    coefficients = face_series(kernels)
    coarse_coefficients = face_series(coarse_kernels)
    reciprocity_error = kernels.reciprocity_difference / float(np.abs(kernels.x).max())
    estimates = {}
    for coefficient in FaceSeries._fields:
        value = getattr(coefficients, coefficient)
        uncertainty = abs(value - getattr(coarse_coefficients, coefficient))
        if coefficient in ("strain_under_pressure", "slope_under_shear"):
            uncertainty += reciprocity_error
        estimates[coefficient] = Estimate(value, uncertainty)
    return BodyNumbers(
        **estimates, unknowns=kernels.unknowns + coarse_kernels.unknowns, factorisations=2
    )


def nearest_end(shape: Shape) -> float:
    """Distance from the middle of the face to the nearest place where the body ends, a side or a
    support; infinite of a half-plane [length].
    """
    return min(shape.face_half_width, shape.least_depth)


# ----------------------------------------------------------------------------- both bodies together
def body_effects(scene: Scene | str | Path) -> BodyEffects:
    """Numbers by which bodies of finite size differ from half-planes in contact: added compliances,
    curvatures, strain by P and tilt by Q, by linear finite elements without contact.

    Each body that is not a half-plane takes two linear systems, about a second. Loads and friction
    do not matter. Of the profile only the datum length counts, the distance from a force at which a
    half-plane's surface counts as unmoved.

    Parameters
    ----------
    scene
        a scene, the name of one of the library, or the path of a scene file

    Returns
    -------
    BodyEffects
        Compliances and curvatures summed over both bodies, strain and slope as differences; zero
        for half-planes. Each uncertainty is that of the meshes.

    Raises
    ------
    InputError
        For bodies that are not covered: curved faces (pads, cylinders), and rollers with free
        sides, which hold no Q; for bodies of finite size under bulk stress.

    Examples
    --------
    >>> from scenes import load_scene
    >>> effects = body_effects(load_scene("blocks"))
    >>> effects.factorisations, effects.strain_under_pressure.value  # two equal blocks
    (2, 0.0)
    """
    scene = scene_of(scene)
    lower_numbers = _body_numbers_in(scene, "lower")
    upper_numbers = lower_numbers if bodies_are_alike(scene) else _body_numbers_in(scene, "upper")
    return effects_of_both_bodies(lower_numbers, upper_numbers, scene)


def _body_numbers_in(scene: Scene, name: Literal["lower", "upper"]) -> BodyNumbers:
    """Numbers by which the finite size of one body of the scene changes a contact, from those of a
    half-plane; zeros for a half-plane. InputError for a body of which they are not derived.
    """
    shape = getattr(scene.bodies, name)
    if isinstance(shape, HalfPlane):
        # OF_HALF_PLANE: numbers that are all zero
        return OF_HALF_PLANE
    require_known_effects(name, shape, scene)
    material = getattr(scene.material, name)
    return body_numbers(name, shape, scene.profile, material, scene.profile.datum_length)


def require_known_effects(name: str, shape: Shape, scene: Scene) -> None:
    """Refuse a body, or loads on it, for which the effects of a finite size are not derived: these
    need a flat face, supports that hold a tangential load, and no bulk stress.

    Parameters
    ----------
    name
        "lower" or "upper", the body's name in the message
    shape
        of the body
    scene
        whose loads may have a bulk stress

    Raises
    ------
    InputError
        With what to take instead.
    """
    if not isinstance(shape, Block | TShape):
        raise InputError(
            f"bodies.{name}: body effects are known for flat faces, and that of a {shape.kind} is"
            " curved; take a block or a t_shape, or solve the scene with finite elements,"
            " `halfplane fe`; in Python, for arcs and flats between them, also"
            ' `solve(scene, bodies="kernel")`'
        )
    if isinstance(shape, Block) and shape.base == "rollers" and shape.sides == "free":
        raise InputError(
            f"bodies.{name}: a body on rollers with free sides holds no tangential load, and its"
            " effects are not known; take base = 'fixed' or sides = 'guided'"
        )
    if not scene.load.is_driven and has_bulk_stress(scene.load.path()):
        raise InputError(
            f"load.bulk_stress_{name}: body effects are known for P and Q, not for the bulk stress"
            " of a body; solve the scene with finite elements"
        )


def effects_of_both_bodies(
    lower_numbers: BodyNumbers, upper_numbers: BodyNumbers, scene: Scene
) -> BodyEffects:
    """Effect of the finite size of both bodies on their contact, from the added compliances,
    curvatures, strains and slopes of each: sums of compliances and curvatures, differences of
    strains and slopes.

        strain by P:  e_P = e_lower - e_upper        tilt by Q:  alpha_Q = a_upper - a_lower

    P presses both bodies alike, and both stretch along x with one sign, so that only the difference
    is slip. Q pulls the lower body along +x, the upper one along -x, so that both faces tilt with
    one sign.

    # notation: e strain of a face along x by P = 1, a slope of its outward displacement by Q = 1

    Parameters
    ----------
    lower_numbers, upper_numbers
        numbers of each body in its own frame, each with an uncertainty. Those called fourth and
        mixed are coefficients of x^4 + s^4 and of x^2 s^2, x and s being the places of displacement
        and force. `unknowns` and `factorisations` count the linear systems that were solved. Where
        both are one object, both differences are 0
    scene
        its datum length, the distance from a force at which a half-plane's surface counts as
        unmoved, and its elastic constants
    """
    effects = BodyEffects(
        datum_length=scene.profile.datum_length,
        normal_compliance=_sum_of_estimates(
            lower_numbers.normal_compliance, upper_numbers.normal_compliance
        ),
        tangential_compliance=_sum_of_estimates(
            lower_numbers.tangential_compliance, upper_numbers.tangential_compliance
        ),
        normal_curvature=_sum_of_estimates(
            lower_numbers.normal_curvature, upper_numbers.normal_curvature
        ),
        tangential_curvature=_sum_of_estimates(
            lower_numbers.tangential_curvature, upper_numbers.tangential_curvature
        ),
        tilt_under_shear=_difference_of_estimates(
            upper_numbers.slope_under_shear, lower_numbers.slope_under_shear
        ),
        strain_under_pressure=_difference_of_estimates(
            lower_numbers.strain_under_pressure, upper_numbers.strain_under_pressure
        ),
        normal_fourth=_sum_of_estimates(lower_numbers.normal_fourth, upper_numbers.normal_fourth),
        tangential_fourth=_sum_of_estimates(
            lower_numbers.tangential_fourth, upper_numbers.tangential_fourth
        ),
        normal_mixed=_sum_of_estimates(lower_numbers.normal_mixed, upper_numbers.normal_mixed),
        tangential_mixed=_sum_of_estimates(
            lower_numbers.tangential_mixed, upper_numbers.tangential_mixed
        ),
        dundurs_beta=dundurs(scene.material).beta,
        unknowns=lower_numbers.unknowns + upper_numbers.unknowns,
        factorisations=lower_numbers.factorisations + upper_numbers.factorisations,
    )
    if upper_numbers is not lower_numbers:
        return effects
    # One body stands for both: its errors cancel from the differences, and it was solved once.
    return replace(
        effects,
        tilt_under_shear=_ZERO_ESTIMATE,
        strain_under_pressure=_ZERO_ESTIMATE,
        unknowns=lower_numbers.unknowns,
        factorisations=lower_numbers.factorisations,
    )


def _sum_of_estimates(first: Estimate, second: Estimate) -> Estimate:
    """Sum of two values. Errors may have equal signs, so the uncertainties are added."""
    return Estimate(first.value + second.value, first.uncertainty + second.uncertainty)


def _difference_of_estimates(first: Estimate, second: Estimate) -> Estimate:
    """Difference of two values. Errors may have opposite signs, so the uncertainties are added."""
    return Estimate(first.value - second.value, first.uncertainty + second.uncertainty)
