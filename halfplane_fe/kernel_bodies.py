r"""Contact of finite bodies without fine meshes of them: the contact compliance of two half-planes
plus the remainder kernels of the bodies, what their finite size adds to surface displacements.

A body displaces its face as a half-plane does plus the smooth kernels of `remainder`, here by
polynomials over all of the side that may touch. So with N, T and K of half-planes (`interface`)::

    N += k_nn of both bodies,   T += k_tt of both,   K += k_tn of the upper body - k_tn of the lower

for in the common frame the two bodies' displacements along x by a pressure have one sign, and slip
is the upper one minus the lower one. That is all that bodies with flat faces are, in every order of
their size, for unlike materials (Dundurs' beta not 0) as well. One pair of condensed half-planes
serves all bodies of these materials.

On curved faces, arcs of pads and cylinders, also on either side of a flat, kernels and forces are
along x and y. The contact acts along the normal n of the middle line of both faces, so that with
all of N, T, K, constants too::

    N' = n_y N n_y + n_x T n_x + n_x K n_y + n_y K^T n_x
    T' = n_y T n_y + n_x N n_x - n_y K n_x - n_x K^T n_y
    K' = n_y K n_y - n_x K^T n_x + n_y T n_x - n_x N n_y

n at the place of the displacement stands left, at that of the force right. The gap is the distance
of the faces along n.

Contact solver, increments and elements of half-planes are those of the finite elements: a
comparison with them checks the kernels, not the solver.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
import scipy

from halfplane_fe.interface import Interface
from halfplane_fe.remainder import (
    RemainderKernels,
    even_exponents,
    kernels_of_slope,
    nearest_end,
    odd_exponents,
    remainder_kernels,
    require_known_effects,
)
from halfplane_fe.supports import bodies_are_alike
from meshes import BodyMesh, MeshSettings, Solid, SurfaceGrading, build
from scenes import (
    Cylinder,
    Elastic,
    HalfPlane,
    InputError,
    Pad,
    Profile,
    Scene,
    Shape,
    ShoulderedPad,
    read_only_copy,
)
from scenes.array_types import Array
from scenes.bodies import Face, arc_depth, face_of

# Least and largest degree of the polynomials in x and s together, and the share of a kernel that
# their first missing terms are.
_LEAST_DEGREE = 12
_LARGEST_DEGREE = 60
_MISSING_SHARE = 1e-8
# Least degree, fewest places of forces at x >= 0 (those at x < 0 would repeat them as mirror
# images), and number of elements where the curvature of the face jumps: with degree 20 W of a flat
# pad, b/a = 0.8, stays 0.2 % too small, with 28 it is within 2e-5.
_DEGREE_AT_JUMP = 28
_N_FORCES_AT_JUMP = 24
_N_ELEMENTS_AT_JUMP = 160
# Elements over the distance of the nearest end of the body, and fewest over the part of the face
# that may touch; growth of their size.
_N_ELEMENTS = 48
_FEWEST_ELEMENTS = 12
_SIZE_GROWTH = 0.1
# Element size of the second mesh over that of the first one: their difference is the error
# estimate.
_FACTOR_OF_COARSE_MESH = 2.0
# Change of the dissipation by a change d of the kernels over the contact, over d E*: by a curvature
# T P0 R = tau, where d = T a^2/2, W of Hertz' contact changes by -2.5 tau = -2 T a^2 E* at most
# (the cycles of `benchmarks/bound.py`).
_WORK_CHANGE_PER_KERNEL_CHANGE = 4.0


class KernelValues(NamedTuple):
    """Displacements at n places by unit forces at m places, minus those of a half-plane, (n, m)
    each [1 / stress]: inwards by a pressing force (k_nn), along x by a force along x (k_tt), and
    along x by a pressing force (k_tn).
    """

    inward_displacement_by_pressure: Array
    x_displacement_by_shear: Array
    x_displacement_by_pressure: Array


@dataclass(frozen=True, eq=False)
class CurvatureJumpKernels:
    """Singular part of the kernels of a body whose face is a flat between arcs: the curvature of
    the face jumps at the ends of the flat, and polynomials do not converge there.

    It is Flamant's displacement along chords of the face, minus that on the flat surface, and in
    k_tt a term of first order in the depth of the face (docs/maps.md)::

        k_tt = 4/(pi^2 E') (Phi(x) - Phi(s))/(x - s),    E' = E/(1 - nu^2)
        2 R Phi = (x + b)^2 ln|x + b| - (x - b)^2 ln|x - b|

    Attributes
    ----------
    flat_half_length, radius
        b of the flat, R of the arcs beside it [length]
    material
        of the body
    """

    flat_half_length: float
    radius: float
    material: Elastic

    def kernels_at(self, x: Array, s: Array) -> KernelValues:
        """Singular part of the displacements at places x (n,) of the face by unit forces at s (m,),
        minus those of a half-plane. The face is a flat |x| < b between arcs of radius R.

        The chord from the force to the place has the slope -(d(x) - d(s))/(x - s), where d is the
        depth of the face below its flat. The singular part is Flamant's displacement at the end of
        this sloping chord, minus that on a flat surface. The displacement along x by a force along
        x has a further term, from the jump of the curvature:

            4/(pi^2 E') (Phi(x) - Phi(s))/(x - s),    E' = E/(1 - nu^2)
            2 R Phi = (x + b)^2 ln|x + b| - (x - b)^2 ln|x - b|

        There are three, (n, m) each [1 / stress]: inwards by a pressing force, along x by a force
        along x, along x by a pressing force.
        """
        depth = arc_depth(x, self.radius, self.flat_half_length)
        depth_at_force = arc_depth(s, self.radius, self.flat_half_length)
        slope_at_force = slope_of_arc(s, self.radius, self.flat_half_length)
        chord_slope = -_divided_differences(depth, depth_at_force, slope_at_force, x, s)
        chord_kernels = kernels_of_slope(chord_slope, self.material)
        poisson_ratio = self.material.poisson_ratio
        plane_strain_modulus = self.material.young_modulus / (1 - poisson_ratio**2)
        divided_difference_of_phi = _divided_differences(
            self._phi(x), self._phi(s), self._phi_slope(s), x, s
        )
        tangential_kernel = (
            chord_kernels.x_displacement_by_shear
            + 4 / (np.pi**2 * plane_strain_modulus) * divided_difference_of_phi
        )
        return KernelValues(
            chord_kernels.inward_displacement_by_pressure,
            tangential_kernel,
            chord_kernels.x_displacement_by_pressure,
        )

    def _phi(self, x: Array) -> Array:
        """Function Phi [length] at places x of a face that is a flat |x| < b between arcs of radius
        R, in the shape of `x`: Phi = [(x + b)^2 ln|x + b| - (x - b)^2 ln|x - b|] / (2 R).

        A unit force along x at s displaces the place x along x. A singular part of this, due to the
        jump of the curvature, is 4/(pi^2 E') (Phi(x) - Phi(s))/(x - s), E' = E/(1 - nu^2).
        """
        xlogy = scipy.special.xlogy  # xlogy(x, y) = x ln y, and 0 where x = 0
        distance_from_left_end = x + self.flat_half_length
        distance_from_right_end = x - self.flat_half_length
        logarithmic_sum = distance_from_left_end * xlogy(
            distance_from_left_end, np.abs(distance_from_left_end)
        ) - distance_from_right_end * xlogy(
            distance_from_right_end, np.abs(distance_from_right_end)
        )
        return np.asarray(logarithmic_sum / (2 * self.radius))

    def _phi_slope(self, x: Array) -> Array:
        """Derivative dPhi/dx at places x of a face that is a flat |x| < b between arcs of radius R,
        in the shape of `x`.

        It takes the place of the divided difference (Phi(x) - Phi(s))/(x - s) where the place x of
        the displacement is the place s of the force.

            2 R Phi = (x + b)^2 ln|x + b| - (x - b)^2 ln|x - b|
            R dPhi/dx = (x + b) ln|x + b| - (x - b) ln|x - b| + b
        """
        xlogy = scipy.special.xlogy  # xlogy(x, y) = x ln y, and 0 where x = 0
        distance_from_left_end = x + self.flat_half_length
        distance_from_right_end = x - self.flat_half_length
        # 2 R dPhi/dx: the derivatives of the terms of the left end, minus those of the right end.
        derivative_at_left_end = (
            2 * xlogy(distance_from_left_end, np.abs(distance_from_left_end))
            + distance_from_left_end
        )
        logarithm_at_right_end = 2 * xlogy(distance_from_right_end, np.abs(distance_from_right_end))
        scaled_slope = derivative_at_left_end - logarithm_at_right_end - distance_from_right_end
        return np.asarray(scaled_slope / (2 * self.radius))


def _divided_differences(
    values_at_x: Array, values_at_s: Array, slope_at_s: Array, x: Array, s: Array
) -> Array:
    """Divided differences (f(x) - f(s))/(x - s) (n, m) of a function f, at places x (n,)
    and s (m,); where both are one place, the slope f'(s).
    """
    distance = x[:, None] - s
    is_same_place = np.abs(distance) < 1e-9 * np.ptp(x)
    difference = values_at_x[:, None] - values_at_s
    return np.where(is_same_place, slope_at_s, difference / np.where(is_same_place, 1.0, distance))


def slope_of_arc(x: Array, radius: float, flat_half_length: float) -> Array:
    """Slope dd/dx at places x of the depth d of a face that is a flat |x| < `flat_half_length`
    between two arcs of a radius.
    """
    distance = np.maximum(np.abs(x) - flat_half_length, 0.0)
    return np.asarray(np.sign(x) * distance / np.sqrt(radius**2 - distance**2))


@dataclass(frozen=True, eq=False)
class FaceKernels:
    """The kernels of one body over |x| <= `reach`, as Chebyshev series: sums of coefficients times
    T_i(x/reach) T_j(s/reach), plus the singular part of faces whose curvature jumps.

    Attributes
    ----------
    reach
        half-width of the side that may touch [length]
    normal_coefficients, tangential_coefficients
        (d+1, d+1) coefficients of k_nn and k_tt, symmetric [1 / stress]
    coupling_coefficients
        (d+1, d+1) coefficients of k_tn [1 / stress]
    jump_kernels
        singular part, added to the series; None for a flat face
    """

    reach: float
    normal_coefficients: Array
    tangential_coefficients: Array
    coupling_coefficients: Array
    jump_kernels: CurvatureJumpKernels | None = None

    def kernels_at(self, x: Array, s: Array) -> KernelValues:
        """Displacements of the face of a body at places x (n,) by unit forces at s (m,), minus
        those of a half-plane, (n, m) each [1 / stress]. They are inwards by a pressing force, along
        x by a force along x, and along x by a pressing force.

        Each is a Chebyshev series, a sum of coefficients times T_i(x/r) T_j(s/r), plus a singular
        part (`jump_kernels`) where the curvature of the face jumps; r is `reach`, the half-width of
        the side that may touch. `normal_coefficients`, `tangential_coefficients` and
        `coupling_coefficients` are those of the three series, (d+1, d+1) each, d their degree in x
        and in s.
        """
        degree = len(self.normal_coefficients) - 1
        polynomials_of_x = np.polynomial.chebyshev.chebvander(x / self.reach, degree)
        polynomials_of_s = np.polynomial.chebyshev.chebvander(s / self.reach, degree)
        smooth_kernels = KernelValues(
            polynomials_of_x @ self.normal_coefficients @ polynomials_of_s.T,
            polynomials_of_x @ self.tangential_coefficients @ polynomials_of_s.T,
            polynomials_of_x @ self.coupling_coefficients @ polynomials_of_s.T,
        )
        if self.jump_kernels is None:
            return smooth_kernels
        singular_kernels = self.jump_kernels.kernels_at(x, s)
        return KernelValues(
            *(
                smooth_kernel + singular_kernel
                for smooth_kernel, singular_kernel in zip(
                    smooth_kernels, singular_kernels, strict=True
                )
            )
        )

    def strain(self, x: Array, s: Array, pressing_force: Array, force_along_x: Array) -> Array:
        """Strain e_xx (n,) that the finite size of the body adds to that of a half-plane, at places
        x (n,) of a flat face. It is caused by forces at s (m,).

        It is the derivative along x of the displacement along x, which is a Chebyshev series in
        x/r and s/r, of degree d in each; r is `reach`, the half-width of the side that may touch.
        `coupling_coefficients` and `tangential_coefficients` (d+1, d+1) are its coefficients
        by a pressing force and by a force along x.

        Parameters
        ----------
        x, s
            (n,) and (m,) places on the face, |x| and |s| <= r [length]
        pressing_force, force_along_x
            (m,) forces at s into the body, and along +x [force per thickness]
        """
        derivative = np.polynomial.chebyshev.chebder
        degree = len(self.normal_coefficients) - 1
        polynomials_of_x = np.polynomial.chebyshev.chebvander(x / self.reach, degree - 1)
        polynomials_of_s = np.polynomial.chebyshev.chebvander(s / self.reach, degree)
        series_by_pressing = (
            derivative(self.coupling_coefficients) @ polynomials_of_s.T @ pressing_force
        )
        series_by_shear = (
            derivative(self.tangential_coefficients) @ polynomials_of_s.T @ force_along_x
        )
        return np.asarray(polynomials_of_x @ (series_by_pressing + series_by_shear) / self.reach)


def fitted_kernels(
    kernels: RemainderKernels,
    jump_kernels: CurvatureJumpKernels | None = None,
    degree: int = _LEAST_DEGREE,
) -> FaceKernels:
    """Least-squares fit of Chebyshev polynomials T_i(x/r) T_j(s/r) to the kernels of a body:
    displacements of its face at x by a unit force at s. The body is its own mirror image in x = 0.

    Displacements in the direction of the force, k_nn and k_tt, have even i + j; those across it,
    k_tn, have odd i + j. By reciprocity k_nn and k_tt are symmetric in x and s.

    # notation: n inwards, t along x; first index displacement, second force; r largest |x|

    Parameters
    ----------
    kernels
        displacements (n, m) of the face at `x` (n,) by unit forces at `x_of_forces` (m,), minus
        those of a half-plane: k_nn, k_tt, k_tn, and k_nt outwards
    jump_kernels
        singular part of the kernels, subtracted before the fit; None for a flat face
    degree
        largest i + j; 12 by default

    Returns
    -------
    FaceKernels
        r, coefficients (degree + 1, degree + 1) of k_nn, k_tt and k_tn, and the singular part.
    """
    if jump_kernels is not None:
        kernels = _without_singular_part(kernels, jump_kernels)
    # Polynomials at all places: chebyshev returns T_0 to T_degree, (n, degree + 1).
    reach = float(np.abs(kernels.x).max())
    chebyshev = np.polynomial.chebyshev.chebvander
    polynomials_of_x = np.asarray(chebyshev(kernels.x / reach, degree), dtype=float)
    polynomials_of_s = np.asarray(chebyshev(kernels.x_of_forces / reach, degree), dtype=float)
    normal_coefficients, tangential_coefficients = _symmetric_coefficients(
        polynomials_of_x,
        polynomials_of_s,
        kernels.inward_displacement_by_pressure,
        kernels.x_displacement_by_shear,
    )
    coupling_coefficients = _coupling_coefficients(
        polynomials_of_x,
        polynomials_of_s,
        kernels.x_displacement_by_pressure,
        kernels.outward_displacement_by_shear,
    )
    return FaceKernels(
        reach, normal_coefficients, tangential_coefficients, coupling_coefficients, jump_kernels
    )


def _without_singular_part(
    kernels: RemainderKernels, jump_kernels: CurvatureJumpKernels
) -> RemainderKernels:
    """Kernels of a body minus their singular part, which stems from jumps of the curvature of the
    face: what is left is smooth enough for polynomials.

    `kernels` are displacements of the face at `x` by unit forces at `x_of_forces`, minus those of a
    half-plane.
    """
    singular_kernels = jump_kernels.kernels_at(kernels.x, kernels.x_of_forces)
    return kernels._replace(
        inward_displacement_by_pressure=kernels.inward_displacement_by_pressure
        - singular_kernels.inward_displacement_by_pressure,
        x_displacement_by_shear=kernels.x_displacement_by_shear
        - singular_kernels.x_displacement_by_shear,
        x_displacement_by_pressure=kernels.x_displacement_by_pressure
        - singular_kernels.x_displacement_by_pressure,
        # By reciprocity k_nt(x, s) = -k_tn(s, x), with k_nt outwards by a force along x and k_tn
        # along x by a pressing force; the singular part of k_tn is symmetric.
        outward_displacement_by_shear=kernels.outward_displacement_by_shear
        + singular_kernels.x_displacement_by_pressure,
    )


def _product_terms(
    polynomials_of_x: Array, polynomials_of_s: Array, pairs: Sequence[tuple[int, int]]
) -> Array:
    """Products T_i(x) T_j(s) at all n places x of displacements and m places s of forces, one
    column for each of k pairs (i, j) of degrees, (n m, k).

    `polynomials_of_x` (n, d + 1) and `polynomials_of_s` (m, d + 1) are T_0 to T_d at these places.
    """
    return np.stack(
        [
            np.multiply.outer(polynomials_of_x[:, i], polynomials_of_s[:, j]).ravel()
            for i, j in pairs
        ],
        axis=1,
    )


def _symmetric_coefficients(
    polynomials_of_x: Array, polynomials_of_s: Array, *symmetric_kernels: Array
) -> Array:
    """Coefficients (k, d + 1, d + 1) of T_i(x) T_j(s) that fit k kernels which are symmetric in x
    and s. They have even i + j up to the degree d, and are the same for (i, j) and (j, i). Least
    squares, in which each pair is fitted once.

    Parameters
    ----------
    polynomials_of_x, polynomials_of_s
        (n, d + 1) and (m, d + 1) T_0 to T_d at the places of the displacements and of the forces
    symmetric_kernels
        k kernels, (n, m) each [1 / stress]
    """
    n_polynomials = polynomials_of_x.shape[1]
    pairs = [(i, j) for i, j in even_exponents(n_polynomials - 1) if i <= j]
    terms = _product_terms(polynomials_of_x, polynomials_of_s, pairs) + _product_terms(
        polynomials_of_x, polynomials_of_s, [(j, i) for i, j in pairs]
    )
    right_sides = np.stack([kernel.ravel() for kernel in symmetric_kernels], axis=1)
    fitted_coefficients = np.linalg.lstsq(terms, right_sides, rcond=None)[0]
    coefficients = np.zeros((len(symmetric_kernels), n_polynomials, n_polynomials))
    for (i, j), coefficient in zip(pairs, fitted_coefficients, strict=True):
        coefficients[:, i, j] += coefficient
        coefficients[:, j, i] += coefficient
    return coefficients


def _coupling_coefficients(
    polynomials_of_x: Array,
    polynomials_of_s: Array,
    x_displacement_by_pressure: Array,
    outward_displacement_by_shear: Array,
) -> Array:
    """Coefficients (d + 1, d + 1) of T_i(x) T_j(s) that fit the kernel k_tn, i + j odd and at most
    the degree d. By reciprocity -k_nt with x and s exchanged has the same ones: both are fitted
    together by least squares.

    Parameters
    ----------
    polynomials_of_x, polynomials_of_s
        (n, d + 1) and (m, d + 1) T_0 to T_d at the places of the displacements and of the forces
    x_displacement_by_pressure, outward_displacement_by_shear
        (n, m) k_tn, along x by a pressing force, and k_nt, outwards by a force along x [1 / stress]
    """
    n_polynomials = polynomials_of_x.shape[1]
    pairs = odd_exponents(n_polynomials - 1)
    terms_of_k_tn = _product_terms(polynomials_of_x, polynomials_of_s, pairs)
    terms_of_minus_k_nt = _product_terms(
        polynomials_of_x, polynomials_of_s, [(j, i) for i, j in pairs]
    )
    right_side = np.concatenate(
        [x_displacement_by_pressure.ravel(), -outward_displacement_by_shear.ravel()]
    )
    fitted_coefficients = np.linalg.lstsq(
        np.concatenate([terms_of_k_tn, terms_of_minus_k_nt]), right_side, rcond=None
    )[0]
    coefficients = np.zeros((n_polynomials, n_polynomials))
    coefficients[tuple(np.transpose(pairs))] = fitted_coefficients
    return coefficients


@dataclass(frozen=True, eq=False)
class BodyKernels:
    """The kernels of one body from a fine and from a coarse mesh."""

    fine: FaceKernels
    coarse: FaceKernels

    def strain(
        self, x: Array, s: Array, pressing_force: Array, force_along_x: Array
    ) -> tuple[Array, Array]:
        """Strain e_xx (n,) that the finite size of the body adds to that of a half-plane, at places
        x (n,) of a flat face; and the estimate of its error (n,).

        The error is the difference of the strains by the fine and by the coarse mesh. Both are
        caused by forces (m,) at s (m,), into the body and along +x [force per thickness].
        """
        fine_strain = self.fine.strain(x, s, pressing_force, force_along_x)
        coarse_strain = self.coarse.strain(x, s, pressing_force, force_along_x)
        return fine_strain, np.abs(fine_strain - coarse_strain)


_FLAT_FACE = Face(np.zeros_like, is_flat=True)


@dataclass(frozen=True, eq=False)
class KernelPair:
    """Kernels of the lower and the upper body, what their finite size adds to the displacement of a
    half-plane's surface; None for a body that is a half-plane.

    `faces` are the shapes of the lower and the upper face.
    """

    lower: BodyKernels | None
    upper: BodyKernels | None
    faces: tuple[Face, Face] = (_FLAT_FACE, _FLAT_FACE)

    def interface_of_bodies(self, half_planes: Interface) -> Interface:
        """Contact compliance of the finite bodies: that of two half-planes plus what the finite
        size of each body adds.

        Where a face is curved, forces and displacements are then turned into the normal and tangent
        of the line midway between the faces. `faces` are the shapes of the lower and upper face;
        `coupling` (slip by pressure) is None where it is zero.
        """
        # (n, n) each, by the kernels of the fine mesh
        added_normal_compliance, added_tangential_compliance, added_coupling = (
            self.added_compliances(half_planes.x, "fine")
        )
        total_coupling = added_coupling
        if half_planes.coupling is not None:
            total_coupling = added_coupling + half_planes.coupling
        interface_along_axes = replace(
            half_planes,
            normal_compliance=read_only_copy(
                half_planes.normal_compliance + added_normal_compliance
            ),
            tangential_compliance=read_only_copy(
                half_planes.tangential_compliance + added_tangential_compliance
            ),
            coupling=read_only_copy(total_coupling) if total_coupling.any() else None,
        )
        if self.faces[0].is_flat and self.faces[1].is_flat:
            return interface_along_axes
        return _on_middle_line(interface_along_axes, *self.faces)

    def relative_work_error(self, x: Array, modulus: float) -> float:
        """Estimate of the relative error of the friction work W by the mesh error of the kernels.

        It is 4 E* times the compliance error: of normal, tangential and coupling compliance each
        half the range of the difference between a fine and a coarse mesh, added up. A compliance
        that is constant over the contact does not change W. `x` (n,) are places of the contact
        nodes, `modulus` is E* [stress].
        """
        compliance_error = 0.0
        for fine_compliance, coarse_compliance in zip(
            self.added_compliances(x, "fine"), self.added_compliances(x, "coarse"), strict=True
        ):
            compliance_difference = fine_compliance - coarse_compliance
            compliance_error += float(np.ptp(compliance_difference)) / 2
        return _WORK_CHANGE_PER_KERNEL_CHANGE * compliance_error * modulus

    def added_compliances(
        self, x: Array, mesh: Literal["fine", "coarse"]
    ) -> tuple[Array, Array, Array]:
        """Compliance that the finite size of both bodies adds to that of two half-planes at nodes
        `x` (n,): normal, tangential and coupling matrix N, T, K, (n, n) each [1 / stress].

        Normal and tangential compliances of the bodies add up; of the coupling, that of the lower
        body is subtracted, so that it is exactly 0 for like bodies. `mesh` is that of the kernels.
        `lower` and `upper` are the kernels of the bodies: displacements of their faces by unit
        forces, minus those of a half-plane; None for a half-plane.
        """
        zeros = np.zeros((len(x), len(x)))
        normal_compliance = zeros
        tangential_compliance = zeros
        coupling = zeros
        for kernels_of_body, sign in ((self.lower, -1.0), (self.upper, 1.0)):
            if kernels_of_body is None:
                continue
            kernels_of_mesh: FaceKernels = getattr(kernels_of_body, mesh)
            displacements = kernels_of_mesh.kernels_at(x, x)  # by unit forces at all nodes
            normal_compliance = normal_compliance + displacements.inward_displacement_by_pressure
            tangential_compliance = tangential_compliance + displacements.x_displacement_by_shear
            if self.lower is not self.upper:
                coupling = coupling + sign * displacements.x_displacement_by_pressure
        return normal_compliance, tangential_compliance, coupling


def _slope_of(face: Face, x: Array) -> Array:
    """Slope (n,) of the depth of a face at places x (n,); 0 of a flat one. `face.arc` is (half the
    length of the flat between two arcs, their radius), None without arcs.
    """
    if face.is_flat or face.arc is None:
        return np.zeros_like(x)
    flat_half_length, radius = face.arc
    return slope_of_arc(x, radius, flat_half_length)


def _on_middle_line(
    interface_along_axes: Interface, lower_face: Face, upper_face: Face
) -> Interface:
    """Contact compliance of two curved faces along the normal and tangent of the line midway
    between them, from that along the axes x and y. The gap is the distance along that normal.

    With n = (n_x, n_y) this normal, at the place of the displacement on the left of N, T and K, and
    at the place of the force on their right:

        N' = n_y N n_y + n_x T n_x + n_x K n_y + n_y K^T n_x
        T' = n_y T n_y + n_x N n_x - n_y K n_x - n_x K^T n_y
        K' = n_y K n_y - n_x K^T n_x + n_y T n_x - n_x N n_y

    # notation: N compliance along y, T along x, K along x by forces along y

    Parameters
    ----------
    interface_along_axes
        compliance of both bodies along x and y, with nodes on flat faces: places `x` of the nodes,
        length of face of each, N, T and K (n, n), K None where it is zero
    lower_face, upper_face
        shapes of the two faces: `depth` of each below its middle, at places x
    """
    # Normal of the line midway between the faces: the lower one lies at y = -depth, the upper one
    # at y = +depth.
    x = interface_along_axes.x
    slope = (_slope_of(upper_face, x) - _slope_of(lower_face, x)) / 2
    n_y = 1 / np.sqrt(1 + slope**2)
    n_x = -slope * n_y

    # N', T' and K'. First index of a weight: the displacement, second: the force.
    weight_xx = np.multiply.outer(n_x, n_x)
    weight_xy = np.multiply.outer(n_x, n_y)
    weight_yx = weight_xy.T
    weight_yy = np.multiply.outer(n_y, n_y)
    compliance_y = interface_along_axes.normal_compliance
    compliance_x = interface_along_axes.tangential_compliance
    coupling_along_axes = interface_along_axes.coupling
    if coupling_along_axes is None:
        coupling_along_axes = np.zeros_like(compliance_x)
    # weight_xy[i, j] is n_x at node i times n_y at node j
    compliance_along_normal = (
        weight_yy * compliance_y
        + weight_xx * compliance_x
        + weight_xy * coupling_along_axes
        + weight_yx * coupling_along_axes.T
    )
    compliance_along_tangent = (
        weight_yy * compliance_x
        + weight_xx * compliance_y
        - weight_yx * coupling_along_axes
        - weight_xy * coupling_along_axes.T
    )
    coupling_on_line = (
        weight_yy * coupling_along_axes
        - weight_xx * coupling_along_axes.T
        + weight_yx * compliance_x
        - weight_xy * compliance_y
    )
    return replace(
        interface_along_axes,
        face_lengths=read_only_copy(interface_along_axes.face_lengths / n_y),
        face_normals=read_only_copy(np.stack([n_x, n_y])),
        gap=read_only_copy((lower_face.depth(x) + upper_face.depth(x)) * n_y),
        normal_compliance=read_only_copy(compliance_along_normal),
        tangential_compliance=read_only_copy(compliance_along_tangent),
        coupling=read_only_copy(coupling_on_line) if coupling_on_line.any() else None,
    )


def check_kernels(scene: Scene) -> None:
    """Refuse a scene that cannot be solved by kernels, the surface displacement by unit forces that
    a body's finite size adds to that of a half-plane.

    Raises
    ------
    InputError
        For faces that are neither flat, nor an arc, nor a flat between two arcs; for blocks on
        rollers with free sides; for bulk stress where a body is of finite size, and where a face is
        curved also for tilt or moment.
    """
    for name in ("lower", "upper"):
        shape = getattr(scene.bodies, name)
        if isinstance(shape, HalfPlane) or is_arc(shape, scene.profile):
            continue
        # What is left: flat faces, whose supports and loads must be ones that kernels serve.
        if isinstance(shape, Pad | ShoulderedPad):
            raise InputError(
                f"bodies.{name}: kernels are known of flat faces, arcs and flats between arcs; the"
                f" face of this {shape.kind} is none: solve the scene with finite elements"
            )
        require_known_effects(name, shape, scene)
    if scene.bodies.faces_are_true and scene.load.has_bulk_or_tilt:
        raise InputError(
            "load: kernels of curved faces take P and Q alone, no bulk stress, tilt or moment:"
            " solve the scene with finite elements"
        )


def is_arc(shape: Shape, profile: Profile) -> bool:
    """Whether the face of a body is a circular arc, or a flat between two arcs."""
    if not isinstance(shape, Cylinder | Pad | ShoulderedPad):
        return False
    arc = face_of(shape, profile).arc
    return arc is not None


def kernel_pair(
    scene: Scene, reach: float, datum_length: float, work_counts: Counter[str]
) -> KernelPair:
    """Kernels of both bodies of a scene over |x| <= `reach` [length]: what their finite size adds
    to the displacement of the face by unit forces, as polynomials.

    Bodies that mirror each other have one set of kernels, computed once. `datum_length` is the
    distance from a force at which a half-plane's surface has no displacement [length]. Linear
    systems and their unknowns are added to the counts in `work_counts`.
    """
    kernels_by_body: dict[str, BodyKernels | None] = {}
    for name in ("lower", "upper"):
        if name == "upper" and bodies_are_alike(scene):
            kernels_by_body[name] = kernels_by_body["lower"]
            continue
        kernels_by_body[name] = body_kernels(scene, name, reach, datum_length, work_counts)
    lower_face, upper_face = (
        face_of(getattr(scene.bodies, name), scene.profile) for name in ("lower", "upper")
    )
    return KernelPair(kernels_by_body["lower"], kernels_by_body["upper"], (lower_face, upper_face))


def _degree_of_kernels(name: str, shape: Solid, reach: float) -> int:
    """Degree of the polynomials that the kernels of a body need over |x| <= `reach` [length]. The
    kernels are displacements of its face by unit forces, minus those of a half-plane.

    The mirror images of a force lie twice the depth d of the body below its face, the corners of
    the face at |x| = w. So the coefficients of Chebyshev polynomials fall as rho^-degree at least:

        rho = u + sqrt(u^2 + 1),  u = 2 d/reach,    and  rho = v + sqrt(v^2 - 1),  v = w/reach

    The degree is the least at which this is 1e-8, but 12 at least and 60 at most, and even. Where
    the second rho is close to 1, the face ends next to the contact, and the largest degree is
    enough: at a free corner a kernel has powers above 2.7 of the distance alone. `name` is that of
    the body, for the message; `shape` has d as its least depth, and w as the half-width of its
    face.

    Source: Trefethen, Approximation Theory and Approximation Practice (2013), theorem 8.1.

    Raises
    ------
    InputError
        For a body so thin that its depth needs more than the largest degree.
    """
    decay = -math.log(_MISSING_SHARE)  # degree times ln rho at which the coefficients are so small
    degree_by_depth = decay / math.asinh(2 * shape.least_depth / reach)
    if degree_by_depth > _LARGEST_DEGREE:
        raise InputError(
            f"bodies.{name}: kernels over |x| <= {reach:.6g} are known of bodies of a sixth of that"
            f" depth and more; this {shape.kind} is thinner: solve the scene with finite elements"
        )
    log_rho_of_corners = math.acosh(max(shape.face_half_width / reach, 1.0))
    degree_by_width = min(decay / max(log_rho_of_corners, 1e-9), _LARGEST_DEGREE)
    return max(_LEAST_DEGREE, 2 * math.ceil(max(degree_by_depth, degree_by_width) / 2))


def body_kernels(
    scene: Scene, name: str, reach: float, datum_length: float, work_counts: Counter[str]
) -> BodyKernels | None:
    """Kernels of one body: what its finite size adds to the displacement of its face at x by a unit
    force at s, as polynomials in x and s for |x|, |s| <= `reach`. None for a half-plane.

    They are computed by linear finite elements on a fine and on a coarse mesh. The difference of
    both estimates their error.

    Parameters
    ----------
    scene
        shapes and materials of the bodies, and profile of the faces
    name
        "lower" or "upper"
    reach
        half-width of the part of the face that may touch [length]
    datum_length
        distance from a force at which a half-plane's surface has no displacement [length]
    work_counts
        counts of linear systems and of their unknowns, added to here

    Raises
    ------
    InputError
        For a body so thin that the polynomials would need more than the largest degree.
    """
    shape = getattr(scene.bodies, name)
    if isinstance(shape, HalfPlane):
        return None
    material = getattr(scene.material, name)

    # Singular part of the kernels, which is left out of the fit; None of a flat face. At the ends
    # of a flat between arcs the curvature jumps, which needs a higher degree and more elements.
    singular_kernels = _singular_kernels(face_of(shape, scene.profile), material)
    has_curvature_jump = singular_kernels is not None and singular_kernels.flat_half_length > 0
    degree = _degree_of_kernels(name, shape, reach)
    n_forces = degree // 2 + 2  # places of unit forces at x >= 0
    n_elements = _N_ELEMENTS  # 48 over the distance to the nearest end of the body
    if has_curvature_jump:
        # _DEGREE_AT_JUMP: 28; _N_FORCES_AT_JUMP: 24; _N_ELEMENTS_AT_JUMP: 160
        degree = max(degree, _DEGREE_AT_JUMP)
        n_forces = max(n_forces, _N_FORCES_AT_JUMP)
        n_elements = _N_ELEMENTS_AT_JUMP
    force_places = reach * np.sin(np.linspace(0.0, np.pi / 2, n_forces))

    # A fine mesh, and one with elements twice as large. `remainder_kernels`: displacements of the
    # face by unit forces at n_forces places x >= 0, those at x < 0 being mirror images;
    # `fitted_kernels`: polynomials plus the singular part.
    kernels_of_meshes = []
    for size_factor in (1.0, _FACTOR_OF_COARSE_MESH):
        body_mesh = _mesh_for_kernels(
            name, shape, scene.profile, reach, n_elements=n_elements, size_factor=size_factor
        )
        computed_kernels = remainder_kernels(body_mesh, material, force_places, datum_length)
        kernels_of_meshes.append(fitted_kernels(computed_kernels, singular_kernels, degree))
        work_counts["kernel unknowns"] += computed_kernels.unknowns
        work_counts["kernel solves"] += 1
    return BodyKernels(*kernels_of_meshes)


def _singular_kernels(face: Face, material: Elastic) -> CurvatureJumpKernels | None:
    """Singular part of the kernels of a body whose face is an arc, or a flat between two arcs; None
    for a flat face. `material` is that of the body.
    """
    if face.arc is None:
        return None
    flat_half_length, radius = face.arc
    return CurvatureJumpKernels(flat_half_length, radius, material)


def _mesh_for_kernels(
    name: str, shape: Solid, profile: Profile, reach: float, *, n_elements: int, size_factor: float
) -> BodyMesh:
    """Mesh of a body from which its kernels are computed: elements of one size over the part of the
    face that may touch, and larger ones away from it.

    Parameters
    ----------
    name, shape
        "lower" or "upper", and the shape of the body
    profile
        of the faces
    reach
        half-width of the part of the face that may touch [length]
    n_elements
        number of elements over the distance to the nearest end of the body; over the reach there is
        a quarter of them at least
    size_factor
        factor on the size of all elements and on its growth: 1 of the fine mesh, 2 of the coarse
    """
    size_by_body = nearest_end(shape) / n_elements
    # _N_ELEMENTS: 48 at the usual fineness; _FEWEST_ELEMENTS: 12 of them over the reach
    size_by_reach = reach * _N_ELEMENTS / _FEWEST_ELEMENTS / n_elements
    element_size = size_factor * min(size_by_body, size_by_reach)
    grading = SurfaceGrading(inner=0.0, outer=reach, size=element_size, edge_size=element_size)
    # _SIZE_GROWTH: growth of the element size per distance, 0.1
    return build(name, shape, profile, grading, MeshSettings(growth=size_factor * _SIZE_GROWTH))
