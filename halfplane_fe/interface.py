"""The interface of two condensed bodies as one value: what nodal contact forces do to gap and slip.

    g = h - n_y delta + n_x U + N p - K^T q + G e    gap
    s = n_y U + n_x delta + K p - T q + S e          slip of the upper face over the lower
    P = n_y p + n_x q,   Q = n_y q - n_x p           what the upper body carries
    e = (sigma_lower, sigma_upper, alpha)            bulk stresses, tilt of the upper body
    M = G_alpha p - S_alpha q                        moment

delta is the normal approach, U the tangential displacement, n the normal out of the lower body. The
upper body tilts about x = y = 0, and M is the moment about that point. On flat faces it is sum x p:
G_alpha = x, S_alpha = 0.

p and q are nodal forces (pressure and shear times weight), p pressing and q along the tangent (n_y,
-n_x) on the lower body. N and T are symmetric, K couples: it is exactly zero for like bodies on
matching meshes. On flat faces n = (0, 1).

`meshed_pair`, `condensed_pair` and `couple` make it from a scene: two bodies, meshed, condensed,
facing each other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve
from scipy.sparse import csr_array

from halfplane_fe.condensed_bodies import BODY_CACHE
from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.path import has_bulk_stress, prescribed_path
from halfplane_fe.supports import has_free_ends, least_face_half_width
from meshes import BodyMesh, MeshSettings, SurfaceGrading, build
from scenes import Block, InputError, Scene, Shape, read_only_copy
from scenes.array_types import Array, Indices

if TYPE_CHECKING:
    from halfplane_fe.mortar import Mortar

# The upper body's frame is reflected in y = 0: y points out of it.
_REFLECTION = np.array([1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Interface:
    """Contact compliance of a pair of bodies: gap and slip by nodal forces at n contact nodes.

    Attributes
    ----------
    x, face_lengths
        (n,) contact nodes of the lower body and the length of face that each stands for [length]
    face_normals
        (2, n) n_x and n_y of the unit normal out of the lower body
    gap
        (n,) initial distance of the faces as they are meshed, unloaded [length]
    normal_compliance, tangential_compliance
        (n, n) N, gap by p, and T, minus slip by q [length per force per thickness]
    coupling
        (n, n) K, slip by p, or None where it is exactly zero
    nearest_x_and_gap
        x and initial distance where the faces are nearest to each other [length]
    gap_and_slip_per_stress_and_tilt
        (2, n, 3) G and S: gap and slip, without contact forces, by a unit of bulk stress in the
        lower body, in the upper one [length per stress], and by a unit of tilt [length]; zero by
        stress in pads and cylinders. None where neither bulk stress nor tilt may act
    has_odd_shear
        whether these are the nodes at x >= 0 of a contact whose shear is odd in x (`mirror`): U
        and Q are zero by symmetry

    # notation: p, q nodal contact forces: pressing, and along x on the lower body
    """

    x: Array
    face_lengths: Array
    face_normals: Array
    gap: Array
    normal_compliance: Array
    tangential_compliance: Array
    coupling: Array | None
    nearest_x_and_gap: tuple[float, float] = (0.0, 0.0)
    has_odd_shear: bool = False
    gap_and_slip_per_stress_and_tilt: Array | None = None

    @property
    def is_flat(self) -> bool:
        """Whether the faces are flat: their unit normal is (0, 1) at every node."""
        return not self.face_normals[0].any()

    def scaled(self, length: float, compliance: float) -> Interface:
        """This contact compliance in other units: x, face lengths and gap over `length`; N, T and K
        over `compliance`; gap and slip by bulk stress over both, by tilt over `length`. The place
        where the faces are nearest, and its gap (`nearest_x_and_gap`), are over `length` too.

        # notation: N normal and T tangential compliance, K coupling (slip by pressure), None where
        # it is exactly zero
        """
        coupling = self.coupling
        if coupling is not None:
            coupling = read_only_copy(coupling / compliance)
        gap_and_slip_per_stress_and_tilt = self.gap_and_slip_per_stress_and_tilt
        if gap_and_slip_per_stress_and_tilt is not None:
            gap_and_slip_per_stress_and_tilt = read_only_copy(
                gap_and_slip_per_stress_and_tilt
                / [length * compliance, length * compliance, length]
            )
        return replace(
            self,
            x=read_only_copy(self.x / length),
            face_lengths=read_only_copy(self.face_lengths / length),
            gap=read_only_copy(self.gap / length),
            normal_compliance=read_only_copy(self.normal_compliance / compliance),
            tangential_compliance=read_only_copy(self.tangential_compliance / compliance),
            coupling=coupling,
            nearest_x_and_gap=(
                self.nearest_x_and_gap[0] / length,
                self.nearest_x_and_gap[1] / length,
            ),
            gap_and_slip_per_stress_and_tilt=gap_and_slip_per_stress_and_tilt,
        )

    def gap_and_slip_by_motion(self, approach: ArrayLike, shift: ArrayLike) -> tuple[Array, Array]:
        """Gap and slip of the n nodes, (..., n) each, by a rigid motion of the upper body: normal
        approach and tangential displacement (`shift`), (..., 1) each at one or many instants
        [length].
        """
        n_x, n_y = self.face_normals
        return n_x * shift - n_y * approach, n_y * shift + n_x * approach

    def resultants(self, pressure: Array, shear: Array) -> tuple[Array, Array]:
        """Resultants P and Q (...) of nodal forces p and q (n, ...), along y and x. Q is 0 on one
        half of a contact whose shear is odd in x.
        """
        n_x, n_y = self.face_normals
        normal_force = n_y @ pressure + n_x @ shear
        tangential_force = n_y @ shear - n_x @ pressure
        return normal_force, 0 * tangential_force if self.has_odd_shear else tangential_force

    def work_per_stress_and_tilt(self, pressure: Array, shear: Array) -> Array:
        """Work F = S q - G p of nodal forces p and q (..., n) in the gap G and the slip S that bulk
        stress and tilt cause. It is (..., 3): per unit of bulk stress in the lower and in the upper
        body, and of tilt, where it is minus the moment M. Zeros (3,) where none of these may act.

        For the bulk stress of a lower half-plane it is -(1/E') sum x q, E' = E/(1 - nu^2).
        `gap_and_slip_per_stress_and_tilt` (2, n, 3) are G and S by a unit of each.
        """
        if self.gap_and_slip_per_stress_and_tilt is None:
            return np.zeros(3)
        return np.asarray(
            shear @ self.gap_and_slip_per_stress_and_tilt[1]
            - pressure @ self.gap_and_slip_per_stress_and_tilt[0]
        )

    def moment(self, pressure: Array, shear: Array) -> Array:
        """Moment M (...) of nodal forces p and q (..., n) about x = 0, in the sense of the load M:
        minus their work per unit of tilt. Zero where neither bulk stress nor tilt may act.
        """
        work_per_unit_of_tilt = self.work_per_stress_and_tilt(pressure, shear)[..., 2]
        return np.asarray(-work_per_unit_of_tilt)


def couple(lower_body: CondensedBody, upper_body: CondensedBody) -> Interface:
    """Contact compliance of two bodies, gap and slip by nodal contact forces, from the condensed
    compliance of each.

    Where flat faces have nodes opposite each other, compliances add node by node; elsewhere the
    faces are joined by dual mortar operators on their middle line. These turn nodal displacements
    into weighted means. The upper body is condensed in its own frame, as if it were a lower one;
    here it is reflected in y = 0.
    """
    if _have_opposite_nodes(lower_body, upper_body):
        return _compliance_node_by_node(lower_body, upper_body)
    return _compliance_by_mortar(lower_body, upper_body)


def _compliance_node_by_node(lower_body: CondensedBody, upper_body: CondensedBody) -> Interface:
    """Contact compliance of two bodies whose flat faces have nodes opposite each other: normal and
    tangential compliances add, since equal and opposite forces act on both.

    The coupling K, slip by pressure, is that of the lower body minus that of the upper one, each
    in its own frame: zero for like bodies (`coupling` of the returned interface is then None).

    `lower_body` and `upper_body` are the condensed bodies: x and face lengths of their n contact
    nodes, and their compliance (2, n, 2, n).
    """
    # compliance[i, :, j, :]: displacement i (0 along x, 1 outward) by force j; the upper body feels
    # -q along x and -p outward.
    lower_compliance = lower_body.compliance
    upper_compliance = upper_body.compliance

    # Displacements along x and y by a unit of each body's bulk stress, and by a unit of tilt.
    stretch_of_lower_body, stretch_of_upper_body, displacement_by_tilt = (
        _displacements_by_stress_and_tilt(lower_body, upper_body)
    )
    # Upper minus lower body: component, node, load. On flat faces x is slip and y is gap.
    slip_and_gap = np.stack(
        [-stretch_of_lower_body, stretch_of_upper_body, displacement_by_tilt], axis=-1
    )
    gap_and_slip = slip_and_gap[::-1]

    coupling = lower_compliance[0, :, 1, :] - upper_compliance[0, :, 1, :]
    return Interface(
        x=read_only_copy(lower_body.x),
        face_lengths=read_only_copy(lower_body.face_lengths),
        face_normals=read_only_copy(
            np.stack([np.zeros_like(lower_body.x), np.ones_like(lower_body.x)])
        ),
        gap=read_only_copy(np.zeros_like(lower_body.x)),
        normal_compliance=read_only_copy(
            lower_compliance[1, :, 1, :] + upper_compliance[1, :, 1, :]
        ),
        tangential_compliance=read_only_copy(
            lower_compliance[0, :, 0, :] + upper_compliance[0, :, 0, :]
        ),
        coupling=read_only_copy(coupling) if coupling.any() else None,
        gap_and_slip_per_stress_and_tilt=read_only_copy(gap_and_slip),
    )


def _compliance_by_mortar(lower_body: CondensedBody, upper_body: CondensedBody) -> Interface:
    """Contact compliance, at the nodes of the lower face, of two bodies with curved faces or with
    nodes that are not opposite each other.

    With C the compliance of one body and B its mortar operator, the compliance is the sum of
    B C B^T over both bodies. B turns nodal displacements into weighted means along the normal and
    the tangent. The blocks of the sum are gap by p (N), minus slip by q (T), and slip by p (K).

    `lower_body` and `upper_body` are the condensed bodies, with n and m contact nodes, each in its
    own frame (y out of the body).

    # notation: in subscripts of einsum d normal and tangent, n node of the lower face, i direction
    # along x and y, m node of the body
    """
    # Operators (2, n, 2, m) of both bodies, with gap, normals and face lengths on the middle line.
    mortar_sides = _mortar_operators(lower_body, upper_body)
    # Sparse, since they hold little but zeros. Flattened (2 n, 2 m): rows are normal components of
    # all nodes, then tangential ones; columns are x components of the body's nodes, then y.
    operator_of_lower_face = csr_array(_flattened(mortar_sides.lower))
    operator_of_upper_face = csr_array(_flattened(mortar_sides.upper))
    compliance_of_both = (
        operator_of_lower_face @ _square_matrix(lower_body.compliance) @ operator_of_lower_face.T
        + operator_of_upper_face
        @ _square_matrix(_in_common_frame(upper_body.compliance))
        @ operator_of_upper_face.T
    )

    # Gap and slip by a unit of each body's bulk stress, and by a unit of tilt of the upper one.
    stretch_of_lower_body, stretch_of_upper_body, displacement_by_tilt = (
        _displacements_by_stress_and_tilt(lower_body, upper_body)
    )
    gap_and_slip_by_load = [
        np.einsum("dnim,im->dn", operator, displacement)
        for operator, displacement in (
            (-mortar_sides.lower, stretch_of_lower_body),
            (mortar_sides.upper, stretch_of_upper_body),
            (mortar_sides.upper, displacement_by_tilt),
        )
    ]
    n_nodes = len(lower_body.x)
    coupling = compliance_of_both[n_nodes:, :n_nodes]
    return Interface(
        x=read_only_copy(lower_body.x),
        face_lengths=read_only_copy(mortar_sides.face_lengths),
        face_normals=read_only_copy(mortar_sides.face_normals),
        gap=read_only_copy(mortar_sides.gap),
        normal_compliance=read_only_copy(compliance_of_both[:n_nodes, :n_nodes]),
        tangential_compliance=read_only_copy(compliance_of_both[n_nodes:, n_nodes:]),
        coupling=read_only_copy(coupling) if coupling.any() else None,
        nearest_x_and_gap=mortar_sides.nearest_x_and_gap,
        gap_and_slip_per_stress_and_tilt=read_only_copy(np.stack(gap_and_slip_by_load, axis=-1)),
    )


def _displacements_by_stress_and_tilt(
    lower_body: CondensedBody, upper_body: CondensedBody
) -> tuple[Array, Array, Array]:
    """Displacements along x and y of the contact nodes in the common frame, by a unit of each of
    three loads: bulk stress of the lower body (2, n) and of the upper one (2, m) [length/stress],
    and tilt of the upper one (2, m) [length].
    """
    stretch_of_lower_body = np.broadcast_to(
        lower_body.displacement_by_stress, (2, len(lower_body.x))
    )
    # _REFLECTION: signs of x and y, 1 and -1
    stretch_of_upper_body = (
        np.broadcast_to(upper_body.displacement_by_stress, (2, len(upper_body.x)))
        * _REFLECTION[:, None]
    )
    displacement_by_tilt = np.stack([upper_body.y, upper_body.x])  # (-y, x) of the common frame
    return stretch_of_lower_body, stretch_of_upper_body, displacement_by_tilt


# Distance of two nodes, in distances of neighbouring nodes there (half an element of order 2),
# within which the mesh error of N - T and K dies out,
_SPACINGS_WITH_MESH_ERROR = 8.5
# and up to which the smooth part is read off beyond that.
_SPACINGS_TO_MEAN_END = 10.5
# Digits behind the point of such a distance: far more than matter, fewer than round-off changes.
_DIGITS_OF_DISTANCES = 9
# Polynomial in x_i and x_j for the smooth part of a compliance: largest degree in both together,
_LARGEST_DEGREE = 8
# nodes that one more degree needs,
_NODES_PER_DEGREE = 25
# and places along the face at which it is fitted.
_N_SAMPLES = 48
# Contact nodes below which no pairs are far enough apart for such a fit.
_FEWEST_NODES = 21


def without_mesh_error(interface: Interface, scene: Scene) -> Interface | None:
    """Contact compliance without the mesh errors of N - T and K between nearby nodes. None where a
    base or the end of a face is so near that its effect cannot be told from these errors, and where
    the contact has fewer than 21 nodes.

    On a smooth isotropic body a unit force displaces its surroundings by -(2/pi E') ln|x - x'|
    along itself, whether it presses or shears. So N - T is smooth, and K smooth on either side of
    its jump at x = x'. A mesh of quadratic elements adds errors over the next ten nodes, whatever
    the element size. They make the contact (by N) longer or shorter, against the stick zone
    (by T), by a part of an element. Wherever edges move, the friction work W then has an error of
    first order in the element size.

    Here N - T is replaced by a smooth fit near the diagonal: N stays, and T changes. So is K, on
    each side of the diagonal. The singular parts of N and T thereby become equal.

    # notation: N normal, T tangential compliance, K coupling (slip by pressure), E' = E/(1 - nu^2)

    Parameters
    ----------
    interface
        the compliances (n, n) as meshed, K None where it is zero, and the places x of the nodes
    scene
        shapes of the bodies: half-width of their faces, and depth of material below
    """
    if not _has_room_beyond_mesh_error(interface, scene):
        return None
    # signed distance (n, n) of two nodes, in distances of neighbouring nodes there
    distances_in_spacings = _distances_in_spacings(interface.x)
    # _SPACINGS_WITH_MESH_ERROR: 8.5 of these, over which the mesh error of a compliance dies out
    is_in_band = np.abs(distances_in_spacings) <= _SPACINGS_WITH_MESH_ERROR
    tangential_compliance = _tangential_with_normal_mesh_error(interface, distances_in_spacings)

    # Coupling in the band: smooth on either side of the diagonal, the mean of both on it.
    coupling = interface.coupling
    if coupling is not None:
        smooth_part_on_left = _smooth_compliance(coupling, interface.x, distances_in_spacings)
        smooth_part_on_right = _smooth_compliance(coupling, interface.x, -distances_in_spacings)
        smooth_part = np.where(distances_in_spacings > 0, smooth_part_on_left, smooth_part_on_right)
        mean_of_sides = (smooth_part_on_left + smooth_part_on_right) / 2
        smooth_part = np.where(distances_in_spacings == 0, mean_of_sides, smooth_part)
        coupling = read_only_copy(np.where(is_in_band, smooth_part, coupling))
    return replace(
        interface, tangential_compliance=read_only_copy(tangential_compliance), coupling=coupling
    )


def _has_room_beyond_mesh_error(interface: Interface, scene: Scene) -> bool:
    """Whether the mesh error of a compliance, over ten nodes, ends before the effect of a base or
    of the end of a face begins. The contact must also have the 21 nodes that a fit of its smooth
    part needs.

    `interface.x` (n,) are places of the contact nodes; `scene` has the shapes of the bodies, with
    the half-width of their faces and the depth of material below.
    """
    spacing = np.diff(interface.x)
    # _SPACINGS_TO_MEAN_END: 10.5 node distances; _FEWEST_NODES: 21
    n_nodes_needed = int(_SPACINGS_TO_MEAN_END)
    room_beside_contact = least_face_half_width(scene) - float(np.abs(interface.x).max())
    return (
        len(interface.x) >= _FEWEST_NODES
        and room_beside_contact >= n_nodes_needed * max(spacing[0], spacing[-1])
        and least_depth(scene) >= 2 * n_nodes_needed * float(spacing.max())
    )


def _tangential_with_normal_mesh_error(interface: Interface, distances_in_spacings: Array) -> Array:
    """Tangential compliance T (n, n) whose mesh error between nearby nodes is replaced by that of
    the normal compliance N, so that N - T is smooth.

    Within 8.5 node distances of the diagonal N - T is replaced by a smooth fit of its values
    further away; beyond, T stays. Elements are exact for a uniform traction, so that each row of
    the change of T has to have the sum 0, weighted by the length of face. The change within 8.5
    node distances alone has not: what is left of the sum is subtracted, spread over 17. Without
    this, the friction work of Cattaneo-Mindlin's cycle stays 6e-5 too small on any mesh.

    Parameters
    ----------
    interface
        condensed compliances N and T, and the length of face of each node, (n,) `face_lengths`
    distances_in_spacings
        (n, n) signed distance of two nodes, in distances of neighbouring nodes there
    """
    # T near the diagonal: N minus the smooth part of N - T.
    # _SPACINGS_WITH_MESH_ERROR: 8.5 node distances, over which the mesh error dies out
    is_in_band = np.abs(distances_in_spacings) <= _SPACINGS_WITH_MESH_ERROR
    smooth_difference = _smooth_compliance(
        interface.normal_compliance - interface.tangential_compliance,
        interface.x,
        np.abs(distances_in_spacings),
    )
    symmetric_difference = (smooth_difference + smooth_difference.T) / 2
    corrected_compliance = np.where(
        is_in_band,
        interface.normal_compliance - symmetric_difference,
        interface.tangential_compliance,
    )

    # Sum 0 of each row of the change.
    is_in_wide_band = np.abs(distances_in_spacings) <= 2 * _SPACINGS_WITH_MESH_ERROR
    weights = interface.face_lengths
    row_sums = (corrected_compliance - interface.tangential_compliance) @ weights
    # The symmetric matrix v_i + v_j on the wide band has these row sums; v are the corrections.
    node_corrections = solve(
        np.diag(is_in_wide_band @ weights) + is_in_wide_band * weights, row_sums
    )
    corrected_compliance -= np.where(
        is_in_wide_band, np.add.outer(node_corrections, node_corrections), 0.0
    )
    return np.asarray(corrected_compliance)


def least_depth(scene: Scene) -> float:
    """Least depth of material below either face; infinite of half-planes [length]."""
    return min(scene.bodies.lower.least_depth, scene.bodies.upper.least_depth)


def _distances_in_spacings(x: Array) -> Array:
    """Signed distance x_i - x_j of the contact nodes, (n, n), over the distance of neighbouring
    nodes, the larger one of i and of j: between equal elements it counts nodes. `x` (n,) ascending.

    The mesh error of large elements reaches 8.5 of their node distances, so that smaller ones
    beside them count as larger. The result is rounded to nine digits behind the point: it is
    compared with a number of nodes, and round-off of x must not decide on which side it lies.
    """
    spacing = np.diff(x)
    spacing_on_right = np.append(spacing, spacing[-1])
    spacing_on_left = np.insert(spacing, 0, spacing[0])
    distance = np.subtract.outer(x, x)
    larger_spacing_beside = np.maximum(spacing_on_right, spacing_on_left)
    # The spacing that counts at a node falls linearly with the distance from a large element.
    # _SPACINGS_WITH_MESH_ERROR: 8.5 node distances, over which the mesh error dies out
    spacing_at_node = np.max(
        larger_spacing_beside - np.abs(distance) / _SPACINGS_WITH_MESH_ERROR, axis=1
    )
    return np.round(
        distance / np.maximum.outer(spacing_at_node, spacing_at_node), _DIGITS_OF_DISTANCES
    )


def _pairs_beyond_mesh_error(
    unit_x: Array, distances_in_spacings: Array
) -> tuple[Indices, Indices]:
    """Pairs of nodes that are so far apart that their compliance has no mesh error: numbers of the
    first and of the second node, (n_pairs,) each.

    The nodes are those next to 48 Chebyshev points along the face, with their mirror images, so
    that a symmetric compliance stays symmetric.

    Parameters
    ----------
    unit_x
        (n,) places of the nodes, from -1 to 1
    distances_in_spacings
        (n, n) distance of two nodes, in distances of neighbouring nodes; 8.5 is far enough
    """
    n_nodes = len(unit_x)
    # _N_SAMPLES: 48
    chebyshev_places = np.cos(np.pi * (np.arange(_N_SAMPLES) + 0.5) / _N_SAMPLES)
    sample_nodes = np.searchsorted(unit_x, chebyshev_places).clip(0, n_nodes - 1)
    sample_nodes = np.union1d(sample_nodes, n_nodes - 1 - sample_nodes)
    # _SPACINGS_WITH_MESH_ERROR: 8.5 node distances, over which the mesh error dies out
    row_samples, column_samples = np.nonzero(  # positions among the sample nodes
        distances_in_spacings[np.ix_(sample_nodes, sample_nodes)] > _SPACINGS_WITH_MESH_ERROR
    )
    return sample_nodes[row_samples], sample_nodes[column_samples]


def _smooth_compliance(matrix: Array, x: Array, distances_in_spacings: Array) -> Array:
    """Smooth part (n, n) of a compliance matrix that has a mesh error between nearby nodes.

    A polynomial in x_i and x_j is fitted to the pairs of nodes further apart than 8.5 distances of
    neighbouring nodes. The mean residual at 8.5 to 10.5 of these is added to it.

    Parameters
    ----------
    matrix
        (n, n) compliance: displacement at node i by a unit force at node j
    x
        (n,) places of the nodes [length]
    distances_in_spacings
        (n, n) distance of two nodes, in distances of neighbouring nodes. If it is signed, only
        pairs on the positive side of the diagonal are fitted
    """
    unit_x = 2 * (x - x[0]) / (x[-1] - x[0]) - 1  # from -1 to 1
    row_nodes, column_nodes = _pairs_beyond_mesh_error(unit_x, distances_in_spacings)

    # Least-squares fit of products of Legendre polynomials; degree 8 at most in both together, one
    # degree for every 25 nodes.
    # _LARGEST_DEGREE: 8; _NODES_PER_DEGREE: 25
    degree = min(_LARGEST_DEGREE, len(x) // _NODES_PER_DEGREE)
    legendre = np.polynomial.legendre.legvander(unit_x, degree)
    exponents = [(k, m) for k in range(degree + 1) for m in range(degree + 1 - k)]
    products = np.stack(
        [legendre[row_nodes, k] * legendre[column_nodes, m] for k, m in exponents], axis=1
    )
    coefficients = np.zeros((degree + 1, degree + 1))
    fitted_coefficients = np.linalg.lstsq(products, matrix[row_nodes, column_nodes], rcond=1e-10)[0]
    coefficients[tuple(np.transpose(exponents))] = fitted_coefficients
    polynomial = legendre @ coefficients @ legendre.T
    return polynomial + _mean_beyond_mesh_error(matrix - polynomial, distances_in_spacings)


def _mean_beyond_mesh_error(matrix: Array, distances_in_spacings: Array) -> Array:
    """Mean of a matrix (n, n) over its entries 8.5 to 10.5 node distances from the diagonal,
    (n, n): for the entry i, j half from row i and half from column j.

    Where the row or the column has no such entries, the other counts alone. `distances_in_spacings`
    (n, n) is the distance of two nodes, in distances of neighbouring nodes.
    """
    # _SPACINGS_WITH_MESH_ERROR: 8.5 node distances; _SPACINGS_TO_MEAN_END: 10.5
    is_counted = (distances_in_spacings > _SPACINGS_WITH_MESH_ERROR) & (
        distances_in_spacings <= _SPACINGS_TO_MEAN_END
    )
    row_means, column_means = (
        (matrix * is_counted).sum(axis=axis) / np.maximum(is_counted.sum(axis=axis), 1)
        for axis in (1, 0)
    )
    # A row or column without such entries has the mean 0 here, which is not counted.
    n_means = np.add.outer(
        np.any(is_counted, axis=1).astype(float), np.any(is_counted, axis=0).astype(float)
    )
    return np.asarray(np.add.outer(row_means, column_means) / np.maximum(n_means, 1.0))


def body_forces(
    lower_body: CondensedBody, upper_body: CondensedBody, pressure: Array, shear: Array
) -> dict[str, Array]:
    """Forces on the contact nodes of each body by the nodal contact forces p and q. They are along
    x and y of the body's own frame, whose y points out of its face.

    Parameters
    ----------
    lower_body, upper_body
        the condensed bodies
    pressure, shear
        (n,) or (n, k) for k load cases, p pressing and q along x on the lower body [force per
        thickness]

    Returns
    -------
    dict
        "lower" and "upper" -> (2, n) or (2, n, k) forces along x and outward.
    """
    if _have_opposite_nodes(lower_body, upper_body):
        return {"lower": np.stack([shear, -pressure]), "upper": np.stack([-shear, -pressure])}
    # Transposed, the mortar operators take forces along the normal and the tangent to nodal forces.
    operators = _mortar_operators(lower_body, upper_body)
    contact_forces = np.concatenate([-pressure, shear])
    case_dimensions = pressure.shape[1:]
    force_on_lower_body = (_flattened(operators.lower).T @ contact_forces).reshape(
        2, -1, *case_dimensions
    )
    force_x, force_y = (_flattened(operators.upper).T @ contact_forces).reshape(
        2, -1, *case_dimensions
    )
    # The upper body takes the opposite forces, and its y is reflected.
    return {"lower": force_on_lower_body, "upper": np.stack([-force_x, force_y])}


def _have_opposite_nodes(lower_body: CondensedBody, upper_body: CondensedBody) -> bool:
    """Whether both faces are flat and have nodes opposite each other, to 1e-9 of the width."""
    are_flat = not (lower_body.y.any() or upper_body.y.any())
    return (
        are_flat
        and lower_body.x.shape == upper_body.x.shape
        and bool(np.allclose(lower_body.x, upper_body.x, rtol=0, atol=1e-9 * np.ptp(lower_body.x)))
    )


def _mortar_operators(lower_body: CondensedBody, upper_body: CondensedBody) -> Mortar:
    """Mortar operators of the two faces in the common frame: they turn nodal displacements into
    weighted means along the normal and the tangent of the middle line.
    """
    from halfplane_fe.mortar import Face, mortar  # noqa: PLC0415 - for faces that do not match

    return mortar(
        Face(lower_body.x, lower_body.y, lower_body.order),
        Face(upper_body.x, -upper_body.y, upper_body.order),
    )


def _flattened(operator: Array) -> Array:
    """A mortar operator (2, n, 2, m), from displacements of m nodes to means at n of them, as a
    matrix (2 n, 2 m).
    """
    return operator.reshape(2 * operator.shape[1], -1)


def _square_matrix(compliance: Array) -> Array:
    """A compliance (2, n, 2, n), displacements along two axes by forces along them, as a matrix
    (2 n, 2 n).
    """
    return compliance.reshape(2 * compliance.shape[1], -1)


def _in_common_frame(compliance: Array) -> Array:
    """Compliance (2, n, 2, n) of the upper body in the common frame, from that in its own frame,
    whose y has the opposite sense.
    """
    return compliance * _REFLECTION[:, None, None, None] * _REFLECTION[:, None]


# Overlap of the faces as they are meshed that is admitted, over their largest gap: curved elements
# sag by a part of (h/a)^2 where the curvature of a face jumps.
_ADMITTED_OVERLAP = 0.01
# The same over the width of the side that may touch, for faces without a gap: rounding.
_ROUNDING = 1e-9


def meshed_pair(
    scene: Scene, mesh: MeshSettings, grading: Callable[[float], SurfaceGrading]
) -> tuple[BodyMesh, BodyMesh]:
    """Meshes of the lower and the upper body of a scene, by gmsh. Where they have one shape and one
    element size, both are one mesh.

    In a scene with bulk stress the free sides of a block are its ends, which the stress pulls:
    `supports["sides"]` of its mesh is then "pulled".

    Parameters
    ----------
    scene
        shapes of the bodies, profile of their faces, and whether a bulk stress pulls at their ends
    mesh
        settings of the meshes
    grading
        function of a factor on the element sizes, 1 for the lower body and `mesh.upper_ratio` for
        the upper one, that returns the element sizes along the face

    Returns
    -------
    lower_mesh, upper_mesh
        Each in its own frame (y out of the body), with its supports by boundary.

    Raises
    ------
    InputError
        For a mesh too large for memory, or a face shorter than the contact.
    """
    shapes = scene.bodies
    lower_mesh = build("lower", shapes.lower, scene.profile, grading(1.0), mesh)
    lower_mesh = _with_pulled_ends(lower_mesh, shapes.lower, scene)
    if shapes.lower == shapes.upper and mesh.upper_ratio == 1:
        return lower_mesh, lower_mesh
    upper_mesh = build("upper", shapes.upper, scene.profile, grading(mesh.upper_ratio), mesh)
    return lower_mesh, _with_pulled_ends(upper_mesh, shapes.upper, scene)


def _with_pulled_ends(body: BodyMesh, shape: Shape, scene: Scene) -> BodyMesh:
    """Mesh of a body whose free sides are marked as ends pulled by the bulk stress: in `supports`,
    boundary -> kind of support. Only a block with such ends in a scene with bulk stress is marked;
    other meshes are returned as they are.
    """
    if not (has_free_ends(shape) and has_bulk_stress(prescribed_path(scene))):
        return body
    return replace(body, supports={**body.supports, "sides": "pulled"})


def condensed_pair(
    scene: Scene, bodies: tuple[BodyMesh, BodyMesh], datum_length: float, work_counts: Counter[str]
) -> tuple[CondensedBody, CondensedBody]:
    """Compliance of the lower and of the upper body at their contact nodes, by static condensation.
    Bodies that this process condensed before come from a cache.

    Parameters
    ----------
    scene
        materials of both bodies; where these are alike and the meshes one, so is the compliance
    bodies
        meshes of the lower and the upper body
    datum_length
        distance from a force at which a half-plane's surface has no displacement [length]
    work_counts
        counts of condensations and factorisations, added to here
    """
    # BODY_CACHE: cache of condensed bodies in this process
    lower_body = BODY_CACHE.condensed_body(
        bodies[0], scene.material.lower, datum_length, work_counts
    )
    if scene.material.alike and bodies[1] is bodies[0]:
        return lower_body, lower_body
    return lower_body, BODY_CACHE.condensed_body(
        bodies[1], scene.material.upper, datum_length, work_counts
    )


def initial_gap(scene: Scene, interface: Interface) -> Array:
    """Initial gap (n,) at the contact nodes [length]: the distance of curved faces as they are
    meshed; where both faces are meshed flat, the height of the profile.

    Parameters
    ----------
    scene
        `bodies.faces_are_true` where curved faces are meshed as such; profile with its height
    interface
        places x of the contact nodes, distance of the meshed faces there (`gap`), and x and
        distance where they are nearest

    Raises
    ------
    InputError
        If the faces overlap before any load, by more than the error of curved elements.
    """
    if not scene.bodies.faces_are_true:
        return np.asarray(scene.profile.height(interface.x))
    # negative where the faces overlap
    x_of_smallest_gap, smallest_gap = interface.nearest_x_and_gap
    overlap = -smallest_gap
    # admitted: a hundredth of the largest gap, or 1e-9 of the width of the side that may touch
    overlap_by_meshing = _ADMITTED_OVERLAP * float(interface.gap.max())
    overlap_by_rounding = _ROUNDING * float(np.ptp(interface.x))
    if overlap > max(overlap_by_meshing, overlap_by_rounding):
        raise InputError(
            f"bodies: initial penetration: the faces overlap by {overlap:.6g} at x ="
            f" {x_of_smallest_gap:.6g}"
        )
    return interface.gap


def bulk_stress_notes(
    scene: Scene, condensed_bodies: tuple[CondensedBody, CondensedBody], tangential_load: float
) -> Iterator[str]:
    """Notes for the user on where the stated bulk stress of a block with pulled ends acts: one
    sentence for each such body.

    Where the base is on rollers the ends carry Q, so that the stress jumps by Q/H across the
    contact (H: height). A fixed base holds the block back: the sentence states which part of the
    stress arrives at the middle of the face, by the slope of its displacement.

    Parameters
    ----------
    scene
        bodies, and load path: without bulk stress there are no notes
    condensed_bodies
        lower and upper body at their contact nodes: places x (n,), material, and displacement
        (2, n) along x and y by a unit of bulk stress
    tangential_load
        largest |Q| [force per thickness]
    """
    if not has_bulk_stress(prescribed_path(scene)):
        return
    for name, condensed_body in zip(("lower", "upper"), condensed_bodies, strict=True):
        body = getattr(scene.bodies, name)
        if not (isinstance(body, Block) and has_free_ends(body)):
            continue
        if body.base == "rollers" and tangential_load > 0:
            yield (
                f"each end of the {name} body carries Q/2, and its stated bulk stress is the mean"
                " of both ends: across the contact it jumps by Q/H,"
                f" {tangential_load / body.height:.3g} at the largest Q"
            )
        elif body.base == "fixed":
            is_in_middle = np.abs(condensed_body.x) <= np.abs(condensed_body.x).max() / 2
            displacement_in_middle = condensed_body.displacement_by_stress[0, is_in_middle]
            # slope of the displacement along x: strain by a unit of bulk stress
            strain_per_stress = np.polyfit(
                condensed_body.x[is_in_middle], displacement_in_middle, 1
            )[0]
            material = condensed_body.material
            modulus = material.young_modulus / (1 - material.poisson_ratio**2)
            stress_ratio = strain_per_stress * modulus
            yield (
                f"the bulk stress of the {name} body is that at its ends: its fixed base holds back"
                f" a part, and {stress_ratio:.0%} of the stress is at the middle of the face; base"
                " = 'rollers' is a specimen cut at its middle plane"
            )
