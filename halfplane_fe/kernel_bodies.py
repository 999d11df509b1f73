r"""Contact of finite bodies without fine meshes of them: the interface of two half-planes plus the
remainder kernels of the bodies.

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

from collections import Counter
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
    require_flat,
)
from halfplane_fe.supports import shapes_alike
from meshes import MeshSettings, SurfaceGrading, build
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
    freeze,
)
from scenes.array_types import Array
from scenes.bodies import Face, arc_depth, face_of

# Largest degree of the polynomials in x and s together, and places of forces at x >= 0; those at x
# < 0 would repeat them as mirror images.
_LARGEST_DEGREE = 12
_N_FORCES = 8
# The same, and the elements, where the curvature of the face jumps: with degree 20 W of a flat pad,
# b/a = 0.8, stays 0.2 % too small, with 28 it is within 2e-5.
_DEGREE_AT_JUMP = 28
_N_FORCES_AT_JUMP = 24
_N_ELEMENTS_AT_JUMP = 160
# Elements over the distance of the nearest place where the body ends, and at least on the side that
# may touch; growth of their size.
_N_ELEMENTS = 48
_FEWEST_ELEMENTS = 12
_SIZE_GROWTH = 0.1
# The second mesh, by which the first one's error is judged.
_FACTOR_OF_COARSE_MESH = 2.0
# Change of the dissipation by a change d of the kernels over the contact, over d E*: by a curvature
# T P0 R = tau, where d = T a^2/2, W of Hertz' contact changes by -2.5 tau = -2 T a^2 E* at most
# (the cycles of `benchmarks/bound.py`).
_WORK_BY_KERNELS = 4.0


class KernelSums(NamedTuple):
    """k_nn, k_tt, k_tn between places, (n, m) each [1 / stress]."""

    normal: Array
    tangential: Array
    along_by_pressure: Array


@dataclass(frozen=True, eq=False)
class PartOfFace:
    """What of the kernels of a body with a flat and arcs is no polynomial where the curvature of
    the face jumps: what the slopes of chords make of Flamant's field, and the first order of the
    depth in k_tt (docs/maps.md)::

        k_tt = 4/(pi^2 E') (Phi(x) - Phi(s))/(x - s),    E' = E/(1 - nu^2)
        2 R Phi = (x + b)^2 ln|x + b| - (x - b)^2 ln|x - b|

    Attributes
    ----------
    flat_half_length, radius
        b, R [length]
    material
        of the body
    """

    flat_half_length: float
    radius: float
    material: Elastic

    def kernels(self, x: Array, s: Array) -> KernelSums:
        """Displacements at places x (n,) by unit forces at s (m,) that no polynomial follows, since
        the curvature of the face jumps where the flat ends, (n, m) each [1 / stress].

        They are Flamant's field along chords of the face, and the first order of the depth.
        """
        depth = arc_depth(x, self.radius, self.flat_half_length)
        depth_at_force = arc_depth(s, self.radius, self.flat_half_length)
        slope_at_force = slope_of_arc(s, self.radius, self.flat_half_length)
        slope = -_divided(depth, depth_at_force, slope_at_force, x, s)
        slope_kernels = kernels_of_slope(slope, self.material)
        poisson_ratio = self.material.poisson_ratio
        modulus = self.material.young_modulus / (1 - poisson_ratio**2)
        depth_kernel = _divided(self._phi(x), self._phi(s), self._phi_rate(s), x, s)
        tangential = slope_kernels.tangential + 4 / (np.pi**2 * modulus) * depth_kernel
        return KernelSums(slope_kernels.normal, tangential, slope_kernels.along_by_pressure)

    def _phi(self, x: Array) -> Array:
        """Phi = [(x + b)^2 ln|x + b| - (x - b)^2 ln|x - b|] / (2 R) at places x [length]; b is the
        half-length of the flat, R the radius of the arcs beside it.
        """
        xlogy = scipy.special.xlogy
        distance_from_left = x + self.flat_half_length
        distance_from_right = x - self.flat_half_length
        logarithmic_sum = distance_from_left * xlogy(
            distance_from_left, np.abs(distance_from_left)
        ) - distance_from_right * xlogy(distance_from_right, np.abs(distance_from_right))
        return np.asarray(logarithmic_sum / (2 * self.radius))

    def _phi_rate(self, x: Array) -> Array:
        """Derivative of Phi = [(x + b)^2 ln|x + b| - (x - b)^2 ln|x - b|] / (2 R) along x; b is the
        half-length of the flat, R the radius of the arcs beside it.
        """
        xlogy = scipy.special.xlogy
        distance_from_left = x + self.flat_half_length
        distance_from_right = x - self.flat_half_length
        rate = 2 * xlogy(distance_from_left, np.abs(distance_from_left)) + distance_from_left
        rate = (
            rate - 2 * xlogy(distance_from_right, np.abs(distance_from_right)) - distance_from_right
        )
        return np.asarray(rate / (2 * self.radius))


def _divided(values: Array, at_force: Array, rate: Array, x: Array, s: Array) -> Array:
    """Divided differences (f(x) - f(s))/(x - s), (n, m), of `values` f at places x (n,) and
    `at_force` f at s (m,); `rate` f' at s where both are one place.
    """
    distance = x[:, None] - s
    is_same_place = np.abs(distance) < 1e-9 * np.ptp(x)
    difference = values[:, None] - at_force
    return np.where(is_same_place, rate, difference / np.where(is_same_place, 1.0, distance))


def slope_of_arc(x: Array, radius: float, flat_half_length: float) -> Array:
    """dd/dx of `arc_depth`."""
    distance = np.maximum(np.abs(x) - flat_half_length, 0.0)
    return np.asarray(np.sign(x) * distance / np.sqrt(radius**2 - distance**2))


@dataclass(frozen=True, eq=False)
class FaceKernels:
    """The kernels of one body over |x| <= `reach`, as polynomials of T_i(x/reach) T_j(s/reach).

    Attributes
    ----------
    reach
        half-width of the side that may touch [length]
    normal, tangential
        (d+1, d+1) coefficients of k_nn and k_tt, symmetric [1 / stress]
    along_by_pressure
        (d+1, d+1) of k_tn [1 / stress]
    part_of_face
        what is added to the polynomials; None of flat faces
    """

    reach: float
    normal: Array
    tangential: Array
    along_by_pressure: Array
    part_of_face: PartOfFace | None = None

    def at(self, x: Array, s: Array) -> KernelSums:
        """Displacement of the face at places x (n,) by unit forces at s (m,), minus that of a
        half-plane: (n, m) each [1 / stress].

        They are inwards by a pressing force, along x by a pull along x, and along x by a pressing
        force (k_nn, k_tt, k_tn).
        """
        degree = len(self.normal) - 1
        polynomials_of_x = np.polynomial.chebyshev.chebvander(x / self.reach, degree)
        polynomials_of_s = np.polynomial.chebyshev.chebvander(s / self.reach, degree)
        smooth_kernels = KernelSums(
            polynomials_of_x @ self.normal @ polynomials_of_s.T,
            polynomials_of_x @ self.tangential @ polynomials_of_s.T,
            polynomials_of_x @ self.along_by_pressure @ polynomials_of_s.T,
        )
        if self.part_of_face is None:
            return smooth_kernels
        face_kernels = self.part_of_face.kernels(x, s)
        return KernelSums(
            *(
                smooth_kernel + face_kernel
                for smooth_kernel, face_kernel in zip(smooth_kernels, face_kernels, strict=True)
            )
        )

    def strain(self, x: Array, s: Array, pressing: Array, along: Array) -> Array:
        """Strain along a flat face at places x (n,) that the finite size of the body adds to that
        of a half-plane, by forces at s (m,).

        It is the derivative along x of the displacement along x.

        Parameters
        ----------
        pressing, along
            (m,) forces into the body and along +x [force / length]
        """
        derivative = np.polynomial.chebyshev.chebder
        degree = len(self.normal) - 1
        polynomials_of_x = np.polynomial.chebyshev.chebvander(x / self.reach, degree - 1)
        polynomials_of_s = np.polynomial.chebyshev.chebvander(s / self.reach, degree)
        by_pressing = derivative(self.along_by_pressure) @ polynomials_of_s.T @ pressing
        by_shear = derivative(self.tangential) @ polynomials_of_s.T @ along
        return np.asarray(polynomials_of_x @ (by_pressing + by_shear) / self.reach)


def fitted_kernels(
    kernels: RemainderKernels, part_of_face: PartOfFace | None = None, degree: int = _LARGEST_DEGREE
) -> FaceKernels:
    """Least-squares fit of Chebyshev polynomials T_i(x/r) T_j(s/r) to the displacement at x by a
    unit force at s on the face of a body that is its own mirror image in x = 0.

    Displacements in the direction of the force, k_nn and k_tt, have even i + j; those across it,
    k_tn, have odd i + j. By reciprocity k_nn and k_tt are symmetric in x and s.

    # notation: n inwards, t along x; first index displacement, second force; r largest |x|

    Parameters
    ----------
    kernels
        displacements of the face by unit forces, minus those of a half-plane
    part_of_face
        a part that is no polynomial, subtracted before the fit; None for a flat face or a pure arc
    degree
        largest i + j
    """
    if part_of_face is not None:
        face_kernels = part_of_face.kernels(kernels.x, kernels.forces_at)
        kernels = kernels._replace(
            normal=kernels.normal - face_kernels.normal,
            tangential=kernels.tangential - face_kernels.tangential,
            along_by_pressure=kernels.along_by_pressure - face_kernels.along_by_pressure,
            # By reciprocity k_nt(x, s) = -k_tn(s, x); this part of k_tn is symmetric.
            outward_by_shear=kernels.outward_by_shear + face_kernels.along_by_pressure,
        )
    reach = float(np.abs(kernels.x).max())
    chebyshev = np.polynomial.chebyshev.chebvander
    polynomials_of_x = chebyshev(kernels.x / reach, degree)
    polynomials_of_s = chebyshev(kernels.forces_at / reach, degree)

    def products(i: int, j: int) -> Array:
        """T_i(x) T_j(s), (n, m)."""
        return np.multiply.outer(polynomials_of_x[:, i], polynomials_of_s[:, j])

    even_pairs = [(i, j) for i, j in even_exponents(degree) if i <= j]
    even_terms = np.stack(
        [(products(i, j) + products(j, i)).ravel() for i, j in even_pairs], axis=1
    )
    kernels_of_one_load = np.stack([kernels.normal.ravel(), kernels.tangential.ravel()], axis=1)
    even_coefficients = np.linalg.lstsq(even_terms, kernels_of_one_load, rcond=None)[0]
    symmetric_coefficients = np.zeros((2, degree + 1, degree + 1))
    for (i, j), coefficient in zip(even_pairs, even_coefficients, strict=True):
        symmetric_coefficients[:, i, j] += coefficient
        symmetric_coefficients[:, j, i] += coefficient

    odd_pairs = odd_exponents(degree)
    by_pressure = np.stack([products(i, j).ravel() for i, j in odd_pairs], axis=1)
    by_shear = np.stack([products(j, i).ravel() for i, j in odd_pairs], axis=1)
    cross_kernels = np.concatenate(
        [kernels.along_by_pressure.ravel(), -kernels.outward_by_shear.ravel()]
    )
    odd_coefficients = np.linalg.lstsq(
        np.concatenate([by_pressure, by_shear]), cross_kernels, rcond=None
    )[0]
    coupling_coefficients = np.zeros((degree + 1, degree + 1))
    coupling_coefficients[tuple(np.transpose(odd_pairs))] = odd_coefficients
    return FaceKernels(
        reach,
        symmetric_coefficients[0],
        symmetric_coefficients[1],
        coupling_coefficients,
        part_of_face,
    )


@dataclass(frozen=True, eq=False)
class BodyKernels:
    """The kernels of one body by two meshes."""

    fine: FaceKernels
    coarse: FaceKernels

    def strain(self, x: Array, s: Array, pressing: Array, along: Array) -> tuple[Array, Array]:
        """Strain (n,) along a flat face at places x that the size of the body adds to that of a
        half-plane, and its difference between the fine and the coarse mesh.

        `pressing` and `along` (m,) are forces at s (m,) into the body and along +x [force/length].
        """
        strain = self.fine.strain(x, s, pressing, along)
        return strain, np.abs(strain - self.coarse.strain(x, s, pressing, along))


_FLAT_FACE = Face(np.zeros_like, flat=True)


@dataclass(frozen=True, eq=False)
class KernelPair:
    """What finite bodies add to two half-planes; None of a body that is a half-plane. Faces of
    lower and upper body.
    """

    lower: BodyKernels | None
    upper: BodyKernels | None
    faces: tuple[Face, Face] = (_FLAT_FACE, _FLAT_FACE)

    def added_to(self, faces: Interface) -> Interface:
        """Contact compliance of the finite bodies: that of two half-planes (`faces`) plus what the
        size of each body adds.

        Where a face is curved, forces and displacements are then turned into the normal and tangent
        of the line midway between the faces.
        """
        added_normal, added_tangential, coupling = self.sums(faces.x, "fine")
        if faces.coupling is not None:
            coupling = coupling + faces.coupling
        with_bodies = replace(
            faces,
            normal=freeze(faces.normal + added_normal),
            tangential=freeze(faces.tangential + added_tangential),
            coupling=freeze(coupling) if coupling.any() else None,
        )
        if self.faces[0].flat and self.faces[1].flat:
            return with_bodies
        return _on_middle_line(with_bodies, *self.faces)

    def share_of_work(self, x: Array, modulus: float) -> float:
        """Estimate of the relative error of the friction work W by the meshes that the kernels come
        from, by their difference on a fine and a coarse mesh.

        A compliance that is constant over the contact does not change W: half the range of the
        difference counts. `x` are the contact nodes, `modulus` is E* [stress].
        """
        difference = 0.0
        for fine, coarse in zip(self.sums(x, "fine"), self.sums(x, "coarse"), strict=True):
            change_of_compliance = fine - coarse
            difference += float(np.ptp(change_of_compliance)) / 2
        return _WORK_BY_KERNELS * difference * modulus

    def sums(self, x: Array, mesh: Literal["fine", "coarse"]) -> tuple[Array, Array, Array]:
        """What the finite size of both bodies adds to the normal, tangential and coupling
        compliance of two half-planes at nodes `x` (n,): three matrices (n, n) [1 / stress].

        Normal and tangential compliances of the bodies add up; of the coupling, that of the lower
        body is subtracted, so that it is exactly 0 of like bodies. `mesh` is that of the kernels.
        """
        zeros = np.zeros((len(x), len(x)))
        normal = zeros
        tangential = zeros
        coupling = zeros
        for body, sign in ((self.lower, -1.0), (self.upper, 1.0)):
            if body is None:
                continue
            kernels_of_body = getattr(body, mesh).at(x, x)
            normal = normal + kernels_of_body[0]
            tangential = tangential + kernels_of_body[1]
            if self.lower is not self.upper:
                coupling = coupling + sign * kernels_of_body[2]
        return normal, tangential, coupling


def _slope_of(face: Face, x: Array) -> Array:
    """How the depth of a face rises along x."""
    if face.flat or face.arc is None:
        return np.zeros_like(x)
    flat_half_length, radius = face.arc
    return slope_of_arc(x, radius, flat_half_length)


def _on_middle_line(pair: Interface, lower: Face, upper: Face) -> Interface:
    """Turn the contact compliance of two curved faces from the axes x and y into the normal and
    tangent of the line midway between the faces, and set the gap along that normal.

    With its normal n = (n_x, n_y), and the place of the displacement left, that of the force right:

        N' = n_y N n_y + n_x T n_x + n_x K n_y + n_y K^T n_x
        T' = n_y T n_y + n_x N n_x - n_y K n_x - n_x K^T n_y
        K' = n_y K n_y - n_x K^T n_x + n_y T n_x - n_x N n_y

    # notation: N compliance along y, T along x, K along x by forces along y

    Parameters
    ----------
    pair
        compliances of both bodies along x and y, at nodes on flat faces
    lower, upper
        depth of each face below its highest point, as a function of x
    """
    x = pair.x
    depth_of_lower = lower.depth(x)
    depth_of_upper = upper.depth(x)
    slope = (_slope_of(upper, x) - _slope_of(lower, x)) / 2
    n_y = 1 / np.sqrt(1 + slope**2)
    n_x = -slope * n_y
    weight_xx = np.multiply.outer(n_x, n_x)
    weight_xy = np.multiply.outer(n_x, n_y)
    weight_yx = weight_xy.T
    weight_yy = np.multiply.outer(n_y, n_y)
    compliance_y = pair.normal
    compliance_x = pair.tangential
    coupling_along_axes = np.zeros_like(compliance_x) if pair.coupling is None else pair.coupling
    normal = (
        weight_yy * compliance_y
        + weight_xx * compliance_x
        + weight_xy * coupling_along_axes
        + weight_yx * coupling_along_axes.T
    )
    tangential = (
        weight_yy * compliance_x
        + weight_xx * compliance_y
        - weight_yx * coupling_along_axes
        - weight_xy * coupling_along_axes.T
    )
    coupling = (
        weight_yy * coupling_along_axes
        - weight_xx * coupling_along_axes.T
        + weight_yx * compliance_x
        - weight_xy * compliance_y
    )
    return replace(
        pair,
        weights=freeze(pair.weights / n_y),
        normals=freeze(np.stack([n_x, n_y])),
        gap=freeze((depth_of_lower + depth_of_upper) * n_y),
        normal=freeze(normal),
        tangential=freeze(tangential),
        coupling=freeze(coupling) if coupling.any() else None,
    )


def check_kernels(scene: Scene) -> None:
    """Refuse scenes that cannot be solved by kernels, the compliance that a body's finite size adds
    to that of a half-plane.

    Raises
    ------
    InputError
        For faces that are neither flat, nor an arc, nor a flat between two arcs; for bodies on
        rollers with free sides; for bulk stress, and on curved faces also tilt or moment.
    """
    for name in ("lower", "upper"):
        shape = getattr(scene.bodies, name)
        if isinstance(shape, HalfPlane) or is_arc(shape, scene.profile):
            continue
        if isinstance(shape, Pad | ShoulderedPad):
            raise InputError(
                f"bodies.{name}: kernels are known of flat faces, arcs and flats between arcs; the"
                f" face of this {shape.kind} is none: solve the scene with finite elements"
            )
        require_flat(name, shape, scene)
    if scene.bodies.faces_are_true and scene.load.has_bulk_or_tilt:
        raise InputError(
            "load: kernels of curved faces take P and Q alone, no bulk stress, tilt or moment:"
            " solve the scene with finite elements"
        )


def is_arc(shape: Shape, profile: Profile) -> bool:
    """Whether the face of a body is an arc, or a flat that goes over into arcs."""
    if not isinstance(shape, Cylinder | Pad | ShoulderedPad):
        return False
    arc = face_of(shape, profile).arc
    return arc is not None


def kernel_pair(scene: Scene, reach: float, datum_length: float, work: Counter[str]) -> KernelPair:
    """For both bodies of a scene, what their finite size adds to the displacement of the face by
    unit forces, as polynomials over |x| <= `reach` [length].

    Bodies alike are computed once. `datum_length` is the distance from a force at which a
    half-plane's surface counts as unmoved [length]; `work` counts linear systems and unknowns.
    """
    bodies: dict[str, BodyKernels | None] = {}
    for name in ("lower", "upper"):
        if name == "upper" and shapes_alike(scene):
            bodies[name] = bodies["lower"]
            continue
        bodies[name] = _kernels_in(scene, name, reach, datum_length, work)
    lower_face, upper_face = (
        face_of(getattr(scene.bodies, name), scene.profile) for name in ("lower", "upper")
    )
    return KernelPair(bodies["lower"], bodies["upper"], (lower_face, upper_face))


def _kernels_in(
    scene: Scene, name: str, reach: float, datum_length: float, work: Counter[str]
) -> BodyKernels | None:
    """What the finite size of one body adds to the displacement of its face by unit forces, as
    polynomials over |x| <= `reach`, from a fine and from a coarse mesh; None of a half-plane.

    Parameters
    ----------
    name
        "lower" or "upper"
    reach
        half-width of the part of the face that may touch [length]
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    work
        counters of linear systems and of their unknowns, raised here
    """
    shape = getattr(scene.bodies, name)
    if isinstance(shape, HalfPlane):
        return None
    material = getattr(scene.material, name)
    arc_of_face = face_of(shape, scene.profile).arc
    part_of_face = None if arc_of_face is None else PartOfFace(*arc_of_face, material)
    has_jump = arc_of_face is not None and arc_of_face[0] > 0
    degree = _DEGREE_AT_JUMP if has_jump else _LARGEST_DEGREE
    n_forces = _N_FORCES_AT_JUMP if has_jump else _N_FORCES
    n_elements = _N_ELEMENTS_AT_JUMP if has_jump else _N_ELEMENTS
    kernels_of_meshes = []
    for size_factor in (1.0, _FACTOR_OF_COARSE_MESH):
        size_by_body = nearest_end(shape) / n_elements
        size_by_reach = reach * _N_ELEMENTS / _FEWEST_ELEMENTS / n_elements
        element_size = size_factor * min(size_by_body, size_by_reach)
        grading = SurfaceGrading(inner=0.0, outer=reach, size=element_size, edge_size=element_size)
        body = build(
            name, shape, scene.profile, grading, MeshSettings(growth=size_factor * _SIZE_GROWTH)
        )
        force_places = reach * np.sin(np.linspace(0.0, np.pi / 2, n_forces))
        computed_kernels = remainder_kernels(body, material, force_places, datum_length)
        kernels_of_meshes.append(fitted_kernels(computed_kernels, part_of_face, degree))
        work["kernel unknowns"] += computed_kernels.unknowns
        work["kernel solves"] += 1
    return BodyKernels(*kernels_of_meshes)
