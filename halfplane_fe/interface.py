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

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve
from scipy.sparse import csr_array

from halfplane_fe.actuators import path_of
from halfplane_fe.condensed_bodies import BODIES
from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.mortar import Mortar, Side, mortar
from halfplane_fe.path import has_bulk_stress
from halfplane_fe.supports import face_room, has_ends
from meshes import BodyMesh, MeshSettings, SurfaceGrading, build
from scenes import Block, InputError, Scene, Shape, freeze
from scenes.array_types import Array

# The upper body's frame is reflected in y = 0: y points out of it.
_REFLECTED = np.array([1.0, -1.0])


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
        """The interface in other units: lengths over `length`, compliances over `compliance`,
        imposed displacements over both.
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
    """Couple two bodies: node by node where flat faces have nodes opposite each other, by mortar on
    their middle line elsewhere.

    The upper body is condensed in its own frame, as if it were a lower one, and reflected in y = 0
    here.
    """
    if _opposite(lower, upper):
        return _coupled_node_by_node(lower, upper)
    return _coupled_by_mortar(lower, upper)


def _coupled_node_by_node(lower: CondensedBody, upper: CondensedBody) -> Interface:
    """The interface of a lower and an upper body whose flat faces have nodes opposite each other:
    compliances add, since equal forces act on both, along x in opposite directions.
    """
    # compliance[i, :, j, :]: displacement i (0 along x, 1 outward) by force j; the upper body feels
    # -q along x and -p outward.
    lower_compliance = lower.compliance
    upper_compliance = upper.compliance
    stretch_of_lower, stretch_of_upper, tilt_of_upper = _imposed_displacements(lower, upper)
    # gap by the displacement outward, slip by that along x: the order of `Interface.imposed`
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
    """The interface of a lower and an upper body whose nodes are not opposite each other: their
    compliances are carried to the nodes of the lower face by mortar operators on the middle line.
    """
    mortar_sides = _mortar(lower, upper)
    # next to nothing but zeros
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
    stretch_of_upper = np.broadcast_to(upper.by_stress, (2, len(upper.x))) * _REFLECTED[:, None]
    tilt_of_upper = np.stack([upper.y, upper.x])  # (-y, x) of the common frame
    return stretch_of_lower, stretch_of_upper, tilt_of_upper


# Element sizes (distances of nodes) within which what only the mesh makes of N - T and K dies out,
_LOCAL = 8.5
# and up to which what is left behind that is read.
_PLATEAU = 10.5
# Digits behind the point of a distance over the element size: far more than matter, and less than
# what round-off changes.
_DIGITS_OF_SIZES = 9
# Largest degree of the polynomial that stands for what is smooth of bodies, in both places
# together,
_DEGREE = 8
# nodes that one more degree needs,
_NODES_A_DEGREE = 25
# and samples that it goes through.
_SAMPLES = 48
# Nodes of the contact side below which there is no such plateau.
_LEAST_NODES = 21


def without_local_difference(faces: Interface, scene: Scene) -> Interface | None:
    """The interface without the parts of N - T and of K that only the mesh makes, N, T and K the
    normal, tangential and coupling compliance; None where these can't be told from the bodies' own.

    On the smooth surface of an isotropic body a force displaces its surroundings by -(2/pi E') ln|x
    - x'| along itself, whether it presses or shears: N and T have one singular part, N - T is
    smooth, and K jumps at x = x', smooth on either side. On a mesh of quadratic elements they have
    parts of their own over the next nodes, the same for every size of element. N finds the nodes
    that touch, T the compliance of those that stick: the same set is longer for the one than for
    the other by a share of an element, and wherever edges move W has an error of first order. Here
    these parts go, T being what is changed:

        D = N - T = S + R,   R_ij = (m_i + m_j)/2 where |x_i - x_j| <= 8.5 h_ij

    S is a polynomial in x_i and x_j through D beyond that distance: what is smooth, of bodies of
    any shape; m_i is the mean of R_ij over 8.5 to 10.5 h_ij, and h_ij the larger size at i and at
    j; of small elements next to large ones that of the large. Elements are right about a uniform
    traction, so that the mesh's part has no sum; its tail beyond 8.5 h_ij, which stays in T, has
    one, and gets the opposite within 17 h_ij: else W of Cattaneo-Mindlin's cycle stays 6e-5 too
    small however small the elements. K goes likewise on each side of its diagonal, which is the
    mean of both. All that it takes from elasticity is that the singular parts are equal: that is
    imposed thereby, and not tested any more. Where ten nodes next to each other see the end of a
    face, or a base, N - T has parts that are not the mesh's.
    """
    spacing = np.diff(faces.x)
    n_nodes = int(_PLATEAU)
    room_beside = face_room(scene) - float(np.abs(faces.x).max())
    if (
        len(faces.x) < _LEAST_NODES
        or room_beside < n_nodes * max(spacing[0], spacing[-1])
        or least_depth(scene) < 2 * n_nodes * float(spacing.max())
    ):
        return None
    sizes_ahead = _sizes_ahead(faces.x)
    is_in_band = np.abs(sizes_ahead) <= _LOCAL
    smooth_difference = _smooth(faces.normal - faces.tangential, faces.x, np.abs(sizes_ahead))
    symmetric_difference = (smooth_difference + smooth_difference.T) / 2
    tangential_compliance = np.where(
        is_in_band, faces.normal - symmetric_difference, faces.tangential
    )
    # What a uniform traction does stays: the correction, with its rows' sums spread over twice the
    # band, has none.
    is_in_double_band = np.abs(sizes_ahead) <= 2 * _LOCAL
    weights = faces.weights
    sums_of_rows = (tangential_compliance - faces.tangential) @ weights
    spread_of_sums = solve(
        np.diag(is_in_double_band @ weights) + is_in_double_band * weights, sums_of_rows
    )
    tangential_compliance -= np.where(
        is_in_double_band, np.add.outer(spread_of_sums, spread_of_sums), 0.0
    )
    coupling = faces.coupling
    if coupling is not None:
        smooth_on_left = _smooth(coupling, faces.x, sizes_ahead)
        smooth_on_right = _smooth(coupling, faces.x, -sizes_ahead)
        smooth_part = np.where(sizes_ahead > 0, smooth_on_left, smooth_on_right)
        mean_of_sides = (smooth_on_left + smooth_on_right) / 2
        smooth_part = np.where(sizes_ahead == 0, mean_of_sides, smooth_part)
        coupling = freeze(np.where(is_in_band, smooth_part, coupling))
    return replace(faces, tangential=freeze(tangential_compliance), coupling=coupling)


def least_depth(scene: Scene) -> float:
    """Least depth of material below either face; infinite of half-planes [length]."""
    return min(scene.bodies.lower.least_depth, scene.bodies.upper.least_depth)


def _sizes_ahead(x: Array) -> Array:
    """(n, n) distance x_i - x_j over the larger element size at i and at j: between equal elements,
    a number of nodes.

    What large elements make reaches into small ones beside them, as far as 8 of the large ones:
    they count as larger there. Between equal elements many nodes are 17 sizes apart, which is a
    limit of `without_local_difference`: the last digits of x must not choose the side.
    """
    spacing = np.diff(x)
    size_on_right = np.append(spacing, spacing[-1])
    size_on_left = np.insert(spacing, 0, spacing[0])
    distance = np.subtract.outer(x, x)
    size_at_node = np.max(
        np.maximum(size_on_right, size_on_left) - np.abs(distance) / _LOCAL, axis=1
    )
    return np.round(distance / np.maximum.outer(size_at_node, size_at_node), _DIGITS_OF_SIZES)


def _smooth(matrix: Array, x: Array, sizes_ahead: Array) -> Array:
    """(n, n) the smooth part of a matrix over pairs of nodes: a polynomial in both places, fitted
    where `sizes_ahead`, the distance of the nodes in element sizes, is beyond the band, plus the
    mean of what it leaves just beyond the band.
    """
    unit_x = 2 * (x - x[0]) / (x[-1] - x[0]) - 1
    chebyshev_places = np.cos(np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES)
    sample_nodes = np.searchsorted(unit_x, chebyshev_places).clip(0, len(x) - 1)
    # with their images: faces that are their own mirror image stay so
    sample_nodes = np.union1d(sample_nodes, len(x) - 1 - sample_nodes)
    row_samples, column_samples = np.nonzero(
        sizes_ahead[np.ix_(sample_nodes, sample_nodes)] > _LOCAL
    )
    row_nodes = sample_nodes[row_samples]
    column_nodes = sample_nodes[column_samples]
    degree = min(_DEGREE, len(x) // _NODES_A_DEGREE)
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
    """Mean of a matrix (n, n) about each entry: the mean of its row and its column over the entries
    8.5 to 10.5 elements ahead; that of one where the other has none there.

    `sizes_ahead` (n, n) is the distance of the entries' nodes over the size of the elements.
    """
    is_on_plateau = (sizes_ahead > _LOCAL) & (sizes_ahead <= _PLATEAU)
    row_means, column_means = (
        (matrix * is_on_plateau).sum(axis=axis) / np.maximum(is_on_plateau.sum(axis=axis), 1)
        for axis in (1, 0)
    )
    # the sums are 0 where there is none
    n_means = np.add.outer(
        np.any(is_on_plateau, axis=1).astype(float), np.any(is_on_plateau, axis=0).astype(float)
    )
    return np.asarray(np.add.outer(row_means, column_means) / np.maximum(n_means, 1.0))


def body_forces(
    lower: CondensedBody, upper: CondensedBody, pressure: Array, shear: Array
) -> dict[str, Array]:
    """Nodal forces (along x, outward) on each body in its own frame, "lower" and "upper", from
    nodal p and q.

    Parameters
    ----------
    pressure, shear
        (n,) or (n, k) for k load cases [force per thickness]

    Returns
    -------
    dict
        (2, n) or (2, n, k), n nodes of the body.
    """
    if _opposite(lower, upper):
        return {"lower": np.stack([shear, -pressure]), "upper": np.stack([-shear, -pressure])}
    sides = _mortar(lower, upper)
    traction = np.concatenate([-pressure, shear])
    cases = pressure.shape[1:]
    on_lower = (_flattened(sides.lower).T @ traction).reshape(2, -1, *cases)
    along_x, along_y = (_flattened(sides.upper).T @ traction).reshape(2, -1, *cases)
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
    return mortar(Side(lower.x, lower.y, lower.order), Side(upper.x, -upper.y, upper.order))


def _flattened(operator: Array) -> Array:
    """(2, n, 2, m) as a matrix (2 n, 2 m)."""
    return operator.reshape(2 * operator.shape[1], -1)


def _square(compliance: Array) -> Array:
    """(2, n, 2, n) as a matrix (2 n, 2 n)."""
    return compliance.reshape(2 * compliance.shape[1], -1)


def _turned(compliance: Array) -> Array:
    """A compliance of the upper body in the common frame."""
    return compliance * _REFLECTED[:, None, None, None] * _REFLECTED[:, None]


# Overlap of the faces as they are meshed that is admitted, over their largest gap: curved elements
# sag by a part of (h/a)^2 where the curvature of a face jumps.
_OVERLAP = 0.01
# The same over the width of the side that may touch, for faces without a gap: rounding.
_ROUNDING = 1e-9


def meshed_pair(
    scene: Scene, mesh: MeshSettings, grading: Callable[[float], SurfaceGrading]
) -> tuple[BodyMesh, BodyMesh]:
    """Meshes of the lower and of the upper body; one mesh for both where they have one shape and
    one element size.

    Parameters
    ----------
    mesh
        settings of the meshes
    grading
        sizes of the surface elements, from the factor by which they are enlarged
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
    """Both bodies condensed, or from the cache where this process condensed them before; `work`
    counts.
    """
    lower = BODIES.condensed(bodies[0], scene.material.lower, datum_length, work)
    if scene.material.alike and bodies[1] is bodies[0]:
        return lower, lower
    return lower, BODIES.condensed(bodies[1], scene.material.upper, datum_length, work)


def initial_gap(scene: Scene, interface: Interface) -> Array:
    """(n,) initial gap in the units of the scene's lengths: that of the faces as made, or the
    profile between two flat ones.

    Raises
    ------
    InputError
        If the faces overlap before any load.
    """
    if not scene.bodies.faces_are_true:
        return np.asarray(scene.profile.height(interface.x))
    x, distance = interface.nearest
    by_meshing = _OVERLAP * float(interface.gap.max())
    rounding = _ROUNDING * float(np.ptp(interface.x))
    if -distance > max(by_meshing, rounding):
        raise InputError(
            f"bodies: initial penetration: the faces overlap by {-distance:.6g} at x = {x:.6g}"
        )
    return interface.gap


def bulk_stress_notes(
    scene: Scene, condensed: tuple[CondensedBody, CondensedBody], tangential_load: float
) -> Iterator[str]:
    """Notes on where the stated bulk stress of a block acts, from the largest |Q| of the path.

    With ends on rollers the ends carry Q, and the stress jumps by Q/H across the contact (H:
    height); with a fixed base, the share that reaches the middle of the face, by the condensed
    body.
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
