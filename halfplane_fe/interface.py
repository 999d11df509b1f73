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

from halfplane_fe.actuators import path_of
from halfplane_fe.condensed_bodies import BODIES
from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.path import has_bulk_stress
from halfplane_fe.supports import face_room, has_ends
from meshes import BodyMesh, MeshSettings, SurfaceGrading, build
from scenes import Block, InputError, Scene, Shape, freeze
from scenes.array_types import Array

if TYPE_CHECKING:
    from halfplane_fe.mortar import Mortar

# The upper body's frame is reflected in y = 0: y points out of it.
_REFLECTION = np.array([1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Interface:
    """Compliance of a pair of bodies facing each other.

    Attributes
    ----------
    x, weights
        (n,) contact points of the lower body and their share of the surface [length]
    normals
        (2, n) n_x and n_y
    gap
        (n,) initial distance of the faces, as they are made [length]
    normal, tangential
        (n, n) N and T [length per force per thickness]
    coupling
        (n, n) K, or None where it is exactly zero
    nearest
        x and initial distance where the faces are nearest to each other [length]
    imposed
        (2, n, 3) G and S: gap and slip by a unit of bulk stress in the lower body, in the upper
        one [length per stress], and by a unit of tilt [length]; nothing by stress in pads and
        cylinders
    guided
        whether this is one half of faces that p and q leave as mirror images (`mirror`): U is
        zero by symmetry, and so is Q
    """

    x: Array
    weights: Array
    normals: Array
    gap: Array
    normal: Array
    tangential: Array
    coupling: Array | None
    nearest: tuple[float, float] = (0.0, 0.0)
    guided: bool = False
    imposed: Array | None = None

    @property
    def flat(self) -> bool:
        """Whether the normal is (0, 1) everywhere."""
        return not self.normals[0].any()

    def scaled(self, length: float, compliance: float) -> Interface:
        """The same pair of bodies in other units: places and gap over `length`, compliances over
        `compliance`, gap and slip by bulk stress over both, by tilt over `length`.
        """
        coupling = self.coupling
        if coupling is not None:
            coupling = freeze(coupling / compliance)
        imposed_displacement = self.imposed
        if imposed_displacement is not None:
            imposed_displacement = freeze(
                imposed_displacement / [length * compliance, length * compliance, length]
            )
        return replace(
            self,
            x=freeze(self.x / length),
            weights=freeze(self.weights / length),
            gap=freeze(self.gap / length),
            normal=freeze(self.normal / compliance),
            tangential=freeze(self.tangential / compliance),
            coupling=coupling,
            nearest=(self.nearest[0] / length, self.nearest[1] / length),
            imposed=imposed_displacement,
        )

    def moved(self, approach: ArrayLike, shift: ArrayLike) -> tuple[Array, Array]:
        """What normal approach and shift of the upper body, (..., 1) of many instants, add to gap
        and slip, each (..., n).
        """
        n_x, n_y = self.normals
        return n_x * shift - n_y * approach, n_y * shift + n_x * approach

    def carried(self, pressure: Array, shear: Array) -> tuple[Array, Array]:
        """P and Q (...) that nodal forces p and q (n, ...) carry."""
        n_x, n_y = self.normals
        normal_force = n_y @ pressure + n_x @ shear
        tangential_force = n_y @ shear - n_x @ pressure
        return normal_force, 0 * tangential_force if self.guided else tangential_force

    def work_of_imposed(self, pressure: Array, shear: Array) -> Array:
        """(..., 3) F = S q - G p of forces (..., n), work of the loads per unit of e: -m_q/E' of
        half-planes below, -M of tilt.
        """
        if self.imposed is None:
            return np.zeros(3)
        return np.asarray(shear @ self.imposed[1] - pressure @ self.imposed[0])


def couple(lower: CondensedBody, upper: CondensedBody) -> Interface:
    """Compliance of a pair of bodies facing each other, from the condensed compliance of each: what
    contact forces do to gap and slip.

    Bodies are coupled node by node where flat faces have nodes opposite each other, by mortar on
    their middle line elsewhere. The upper body is condensed in its own frame, as if it were a lower
    one; here it is reflected in y = 0.
    """
    if _opposite(lower, upper):
        return _coupled_node_by_node(lower, upper)
    return _coupled_by_mortar(lower, upper)


def _coupled_node_by_node(lower: CondensedBody, upper: CondensedBody) -> Interface:
    """Compliance of two bodies whose flat faces have nodes opposite each other: normal and
    tangential compliances add, since equal and opposite forces act on both.

    The coupling of pressure and slip is the difference of both bodies', zero for like ones.
    """
    # compliance[i, :, j, :]: displacement i (0 along x, 1 outward) by force j; the upper body feels
    # -q along x and -p outward.
    lower_compliance = lower.compliance
    upper_compliance = upper.compliance
    stretch_of_lower, stretch_of_upper, tilt_of_upper = _imposed_displacements(lower, upper)
    # Reversed, as the gap comes first: it changes by displacement outward, slip by that along x.
    imposed_displacement = np.stack([-stretch_of_lower, stretch_of_upper, tilt_of_upper], axis=-1)[
        ::-1
    ]
    coupling = lower_compliance[0, :, 1, :] - upper_compliance[0, :, 1, :]
    return Interface(
        x=freeze(lower.x),
        weights=freeze(lower.weights),
        normals=freeze(np.stack([np.zeros_like(lower.x), np.ones_like(lower.x)])),
        gap=freeze(np.zeros_like(lower.x)),
        normal=freeze(lower_compliance[1, :, 1, :] + upper_compliance[1, :, 1, :]),
        tangential=freeze(lower_compliance[0, :, 0, :] + upper_compliance[0, :, 0, :]),
        coupling=freeze(coupling) if coupling.any() else None,
        imposed=freeze(imposed_displacement),
    )


def _coupled_by_mortar(lower: CondensedBody, upper: CondensedBody) -> Interface:
    """Compliance of two bodies with curved faces, or with nodes that are not opposite each other,
    at the nodes of the lower face.

    With mortar operators B, which average displacement over the shape functions of these nodes, the
    compliance is the sum of B C B^T over both bodies, C being that of each. Its blocks are those of
    gap by p, of slip by q, and of slip by p.
    """
    mortar_sides = _mortar(lower, upper)
    # Sparse: these operators hold little but zeros.
    operator_of_lower = csr_array(_flattened(mortar_sides.lower))
    operator_of_upper = csr_array(_flattened(mortar_sides.upper))
    compliance_of_both = (
        operator_of_lower @ _square(lower.compliance) @ operator_of_lower.T
        + operator_of_upper @ _square(_turned(upper.compliance)) @ operator_of_upper.T
    )
    stretch_of_lower, stretch_of_upper, tilt_of_upper = _imposed_displacements(lower, upper)
    imposed_displacement = [
        np.einsum("dnim,im->dn", operator, displacement)
        for operator, displacement in (
            (-mortar_sides.lower, stretch_of_lower),
            (mortar_sides.upper, stretch_of_upper),
            (mortar_sides.upper, tilt_of_upper),
        )
    ]
    n_nodes = len(lower.x)
    coupling = compliance_of_both[n_nodes:, :n_nodes]
    return Interface(
        x=freeze(lower.x),
        weights=freeze(mortar_sides.weights),
        normals=freeze(mortar_sides.normals),
        gap=freeze(mortar_sides.gap),
        normal=freeze(compliance_of_both[:n_nodes, :n_nodes]),
        tangential=freeze(compliance_of_both[n_nodes:, n_nodes:]),
        coupling=freeze(coupling) if coupling.any() else None,
        nearest=mortar_sides.nearest,
        imposed=freeze(np.stack(imposed_displacement, axis=-1)),
    )


def _imposed_displacements(
    lower: CondensedBody, upper: CondensedBody
) -> tuple[Array, Array, Array]:
    """(2, n) of the contact nodes in the common frame: of each body by a unit of its bulk stress,
    and of the upper one by a unit of tilt.
    """
    stretch_of_lower = np.broadcast_to(lower.by_stress, (2, len(lower.x)))
    stretch_of_upper = np.broadcast_to(upper.by_stress, (2, len(upper.x))) * _REFLECTION[:, None]
    tilt_of_upper = np.stack([upper.y, upper.x])  # (-y, x) of the common frame
    return stretch_of_lower, stretch_of_upper, tilt_of_upper


# Element sizes (distances of nodes) within which what only the mesh makes of N - T and K dies out,
_SIZES_IN_BAND = 8.5
# and up to which what is left behind that is read.
_SIZES_TO_PLATEAU_END = 10.5
# Digits behind the point of a distance over the element size: far more than matter, and less than
# what round-off changes.
_DIGITS_OF_SIZES = 9
# Largest degree of the polynomial that stands for what is smooth of bodies, in both places
# together,
_LARGEST_DEGREE = 8
# nodes that one more degree needs,
_NODES_PER_DEGREE = 25
# and samples that it goes through.
_N_SAMPLES = 48
# Nodes of the contact side below which there is no such plateau.
_FEWEST_NODES = 21


def without_local_difference(faces: Interface, scene: Scene) -> Interface | None:
    """Contact compliance without what only the mesh adds to N - T and to K over nearby nodes; None
    where that cannot be told from what a near base or end of a face adds.

    On a smooth isotropic body a unit force displaces its surroundings by -(2/pi E') ln|x - x'|
    along itself, whether it presses or shears. So N - T is smooth, and K smooth on either side of
    its jump at x = x'. A mesh of quadratic elements adds parts over the next ten nodes, whatever
    the element size. They make the zone that touches (by N) longer or shorter than the zone that
    sticks (by T) by a part of an element. Wherever edges move, W then has an error of first order.

    Here N - T is replaced by a smooth fit near the diagonal, T being what changes; K likewise on
    each side. That the singular parts of N and T are equal is imposed thereby, not tested.

    # notation: N normal, T tangential compliance, K coupling, E' = E/(1 - nu^2)
    """
    if not _has_room_for_plateau(faces, scene):
        return None
    sizes_ahead = _sizes_ahead(faces.x)
    is_in_band = np.abs(sizes_ahead) <= _SIZES_IN_BAND
    tangential_compliance = _tangential_without_mesh_part(faces, sizes_ahead)
    coupling = faces.coupling
    if coupling is not None:
        smooth_on_left = _smooth(coupling, faces.x, sizes_ahead)
        smooth_on_right = _smooth(coupling, faces.x, -sizes_ahead)
        smooth_part = np.where(sizes_ahead > 0, smooth_on_left, smooth_on_right)
        mean_of_sides = (smooth_on_left + smooth_on_right) / 2
        smooth_part = np.where(sizes_ahead == 0, mean_of_sides, smooth_part)
        coupling = freeze(np.where(is_in_band, smooth_part, coupling))
    return replace(faces, tangential=freeze(tangential_compliance), coupling=coupling)


def _has_room_for_plateau(faces: Interface, scene: Scene) -> bool:
    """Whether the ends of the faces and the bases of the bodies are further away than the ten nodes
    over which the mesh distorts a compliance, and the contact has enough nodes to fit its rest.
    """
    spacing = np.diff(faces.x)
    n_nodes = int(_SIZES_TO_PLATEAU_END)
    room_beside = face_room(scene) - float(np.abs(faces.x).max())
    return (
        len(faces.x) >= _FEWEST_NODES
        and room_beside >= n_nodes * max(spacing[0], spacing[-1])
        and least_depth(scene) >= 2 * n_nodes * float(spacing.max())
    )


def _tangential_without_mesh_part(faces: Interface, sizes_ahead: Array) -> Array:
    """Tangential compliance T (n, n) with the discretisation error that the normal one, N, has
    between nearby nodes, in the place of its own: their difference N - T is smooth then.

    Within 8.5 element sizes of the diagonal N - T is replaced by a smooth fit of its values further
    away; there T stays. Elements are exact for a uniform traction, and so the error of a row of T
    has the sum 0. Its tail beyond 8.5 sizes, which stays in T, has not: the opposite of the tail's
    sum is spread over 17 sizes. Without this, W of Cattaneo-Mindlin's cycle stays 6e-5 too small on
    any mesh.

    Parameters
    ----------
    faces
        condensed compliances N and T, and the length of face of each node, (n,) `weights`
    sizes_ahead
        (n, n) distance of two nodes over the size of the elements there, with its sign
    """
    is_in_band = np.abs(sizes_ahead) <= _SIZES_IN_BAND
    smooth_difference = _smooth(faces.normal - faces.tangential, faces.x, np.abs(sizes_ahead))
    symmetric_difference = (smooth_difference + smooth_difference.T) / 2
    tangential_compliance = np.where(
        is_in_band, faces.normal - symmetric_difference, faces.tangential
    )
    is_in_double_band = np.abs(sizes_ahead) <= 2 * _SIZES_IN_BAND
    weights = faces.weights
    sums_of_rows = (tangential_compliance - faces.tangential) @ weights
    # A symmetric matrix v_i + v_j on the double band has these sums.
    spread_of_sums = solve(
        np.diag(is_in_double_band @ weights) + is_in_double_band * weights, sums_of_rows
    )
    tangential_compliance -= np.where(
        is_in_double_band, np.add.outer(spread_of_sums, spread_of_sums), 0.0
    )
    return np.asarray(tangential_compliance)


def least_depth(scene: Scene) -> float:
    """Least depth of material below either face; infinite of half-planes [length]."""
    return min(scene.bodies.lower.least_depth, scene.bodies.upper.least_depth)


def _sizes_ahead(x: Array) -> Array:
    """Distance x_i - x_j of the contact nodes over the larger element size at i and at j, (n, n):
    between equal elements, a number of nodes with a sign.

    Large elements disturb the compliance as far as 8.5 of their sizes away, so that small elements
    beside them count as larger. Distances are rounded to nine digits behind the point: they are
    compared with a number of nodes, and round-off of x must not decide on which side they lie.
    """
    spacing = np.diff(x)
    size_on_right = np.append(spacing, spacing[-1])
    size_on_left = np.insert(spacing, 0, spacing[0])
    distance = np.subtract.outer(x, x)
    size_at_node = np.max(
        np.maximum(size_on_right, size_on_left) - np.abs(distance) / _SIZES_IN_BAND, axis=1
    )
    return np.round(distance / np.maximum.outer(size_at_node, size_at_node), _DIGITS_OF_SIZES)


def _smooth(matrix: Array, x: Array, sizes_ahead: Array) -> Array:
    """Smooth part of a compliance over pairs of nodes, (n, n), which elements distort between nodes
    that are near each other.

    A polynomial in both places is fitted to pairs further apart than 8.5 element sizes. The mean of
    what it leaves at 8.5 to 10.5 sizes is added.

    Parameters
    ----------
    matrix
        (n, n) compliance between the nodes
    x
        (n,) their places
    sizes_ahead
        (n, n) distance of two nodes over the element size; with a sign, if only pairs on one side
        are to count
    """
    unit_x = 2 * (x - x[0]) / (x[-1] - x[0]) - 1
    chebyshev_places = np.cos(np.pi * (np.arange(_N_SAMPLES) + 0.5) / _N_SAMPLES)
    sample_nodes = np.searchsorted(unit_x, chebyshev_places).clip(0, len(x) - 1)
    # Together with their mirror images, so that a symmetric compliance stays symmetric.
    sample_nodes = np.union1d(sample_nodes, len(x) - 1 - sample_nodes)
    row_samples, column_samples = np.nonzero(
        sizes_ahead[np.ix_(sample_nodes, sample_nodes)] > _SIZES_IN_BAND
    )
    row_nodes = sample_nodes[row_samples]
    column_nodes = sample_nodes[column_samples]
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
    return polynomial + _plateau(matrix - polynomial, sizes_ahead)


def _plateau(matrix: Array, sizes_ahead: Array) -> Array:
    """Mean, for each pair of nodes, of a matrix (n, n) over entries 8.5 to 10.5 element sizes from
    its diagonal: half from the row of the pair, half from its column.

    Where the row or the column has no such entries, the other counts alone. `sizes_ahead` (n, n) is
    the distance of two nodes over the size of the elements.
    """
    is_on_plateau = (sizes_ahead > _SIZES_IN_BAND) & (sizes_ahead <= _SIZES_TO_PLATEAU_END)
    row_means, column_means = (
        (matrix * is_on_plateau).sum(axis=axis) / np.maximum(is_on_plateau.sum(axis=axis), 1)
        for axis in (1, 0)
    )
    # A row or column without such entries has the mean 0 here, which is not counted.
    n_means = np.add.outer(
        np.any(is_on_plateau, axis=1).astype(float), np.any(is_on_plateau, axis=0).astype(float)
    )
    return np.asarray(np.add.outer(row_means, column_means) / np.maximum(n_means, 1.0))


def body_forces(
    lower: CondensedBody, upper: CondensedBody, pressure: Array, shear: Array
) -> dict[str, Array]:
    """Forces on the contact nodes of each body, in its own frame, by the nodal forces of pressure
    and shear of the contact. In the frame of either body y points out of its face.

    Parameters
    ----------
    lower, upper
        the condensed bodies
    pressure, shear
        (n,) or (n, k) for k load cases, p pressing and q along x on the lower body [force per
        thickness]

    Returns
    -------
    dict
        "lower" and "upper" -> (2, n) or (2, n, k) forces along x and outward.
    """
    if _opposite(lower, upper):
        return {"lower": np.stack([shear, -pressure]), "upper": np.stack([-shear, -pressure])}
    # from displacements of either body to those that the forces work on: rows normal, then along x
    mortar_matrices = _mortar(lower, upper)
    forces = np.concatenate([-pressure, shear])
    cases = pressure.shape[1:]
    on_lower = (_flattened(mortar_matrices.lower).T @ forces).reshape(2, -1, *cases)
    along_x, along_y = (_flattened(mortar_matrices.upper).T @ forces).reshape(2, -1, *cases)
    return {"lower": on_lower, "upper": np.stack([-along_x, along_y])}


def _opposite(lower: CondensedBody, upper: CondensedBody) -> bool:
    """Whether both faces are flat and have their nodes opposite each other."""
    flat = not (lower.y.any() or upper.y.any())
    return (
        flat
        and lower.x.shape == upper.x.shape
        and bool(np.allclose(lower.x, upper.x, rtol=0, atol=1e-9 * np.ptp(lower.x)))
    )


def _mortar(lower: CondensedBody, upper: CondensedBody) -> Mortar:
    """The two faces coupled in the common frame."""
    from halfplane_fe.mortar import Side, mortar  # noqa: PLC0415 - for faces that do not match

    return mortar(Side(lower.x, lower.y, lower.order), Side(upper.x, -upper.y, upper.order))


def _flattened(operator: Array) -> Array:
    """(2, n, 2, m) as a matrix (2 n, 2 m)."""
    return operator.reshape(2 * operator.shape[1], -1)


def _square(compliance: Array) -> Array:
    """(2, n, 2, n) as a matrix (2 n, 2 n)."""
    return compliance.reshape(2 * compliance.shape[1], -1)


def _turned(compliance: Array) -> Array:
    """A compliance of the upper body in the common frame."""
    return compliance * _REFLECTION[:, None, None, None] * _REFLECTION[:, None]


# Overlap of the faces as they are meshed that is admitted, over their largest gap: curved elements
# sag by a part of (h/a)^2 where the curvature of a face jumps.
_ADMITTED_OVERLAP = 0.01
# The same over the width of the side that may touch, for faces without a gap: rounding.
_ROUNDING = 1e-9


def meshed_pair(
    scene: Scene, mesh: MeshSettings, grading: Callable[[float], SurfaceGrading]
) -> tuple[BodyMesh, BodyMesh]:
    """Mesh the lower and the upper body of a scene by gmsh; where they have one shape and one
    element size, one mesh serves for both.

    Parameters
    ----------
    scene
        shapes of the bodies, profile of their faces, and whether a bulk stress pulls at their ends
    mesh
        settings of the meshes
    grading
        function from a factor on the element sizes (that of the upper over the lower body) to the
        sizes of the elements along the face
    """
    shapes = scene.bodies
    lower = build("lower", shapes.lower, scene.profile, grading(1.0), mesh)
    lower = _with_ends(lower, shapes.lower, scene)
    if shapes.lower == shapes.upper and mesh.upper_ratio == 1:
        return lower, lower
    upper = build("upper", shapes.upper, scene.profile, grading(mesh.upper_ratio), mesh)
    return lower, _with_ends(upper, shapes.upper, scene)


def _with_ends(body: BodyMesh, shape: Shape, scene: Scene) -> BodyMesh:
    """The body with its free sides as ends that the bulk stress pulls, where it is a block and the
    scene has such a stress.
    """
    if not (has_ends(shape) and has_bulk_stress(path_of(scene))):
        return body
    return replace(body, supports={**body.supports, "sides": "pulled"})


def condensed_pair(
    scene: Scene, bodies: tuple[BodyMesh, BodyMesh], datum_length: float, work: Counter[str]
) -> tuple[CondensedBody, CondensedBody]:
    """Both bodies condensed to their contact nodes; bodies that this process condensed before come
    from a cache.

    `bodies` are the meshes of the lower and the upper one, `datum_length` is the distance from a
    force at which a half-plane's surface counts as unmoved [length]. Counters in `work` are raised.
    """
    lower = BODIES.condensed(bodies[0], scene.material.lower, datum_length, work)
    if scene.material.alike and bodies[1] is bodies[0]:
        return lower, lower
    return lower, BODIES.condensed(bodies[1], scene.material.upper, datum_length, work)


def initial_gap(scene: Scene, interface: Interface) -> Array:
    """Initial gap (n,) at the contact nodes [length]: the distance of curved faces as they are
    meshed; where both faces are meshed flat, the height of the profile.

    Raises
    ------
    InputError
        If the faces overlap before any load, by more than curved elements sag.
    """
    if not scene.bodies.faces_are_true:
        return np.asarray(scene.profile.height(interface.x))
    x, distance = interface.nearest  # where the faces are nearest to each other
    by_meshing = _ADMITTED_OVERLAP * float(interface.gap.max())
    rounding = _ROUNDING * float(np.ptp(interface.x))
    if -distance > max(by_meshing, rounding):
        raise InputError(
            f"bodies: initial penetration: the faces overlap by {-distance:.6g} at x = {x:.6g}"
        )
    return interface.gap


def bulk_stress_notes(
    scene: Scene, condensed: tuple[CondensedBody, CondensedBody], tangential_load: float
) -> Iterator[str]:
    """Sentences for the reader on where the stated bulk stress of a block with pulled ends acts.

    Where the base is on rollers the ends carry Q, so that the stress jumps by Q/H across the
    contact (H: height). A fixed base holds the block back: the sentence states which part of the
    stress arrives at the middle of the face, by the slope of its displacement.

    `condensed` are the lower and the upper body, `tangential_load` is the largest |Q| of the path.
    """
    if not has_bulk_stress(path_of(scene)):
        return
    for name, condensed_body in zip(("lower", "upper"), condensed, strict=True):
        body = getattr(scene.bodies, name)
        if not (isinstance(body, Block) and has_ends(body)):
            continue
        if body.base == "rollers" and tangential_load > 0:
            yield (
                f"each end of the {name} body carries Q/2, and its stated bulk stress is the mean"
                " of both ends: across the contact it jumps by Q/H,"
                f" {tangential_load / body.height:.3g} at the largest Q"
            )
        elif body.base == "fixed":
            is_in_middle = np.abs(condensed_body.x) <= np.abs(condensed_body.x).max() / 2
            displacement_in_middle = condensed_body.by_stress[0, is_in_middle]
            strain_by_stress = np.polyfit(
                condensed_body.x[is_in_middle], displacement_in_middle, 1
            )[0]
            material = condensed_body.material
            modulus = material.young_modulus / (1 - material.poisson_ratio**2)
            share_at_face = strain_by_stress * modulus
            yield (
                f"the bulk stress of the {name} body is that at its ends: its fixed base holds back"
                f" a part, and {share_at_face:.0%} of the stress is at the middle of the face; base"
                " = 'rollers' is a specimen cut at its middle plane"
            )
