"""The interface of two condensed bodies as one value: what nodal contact forces do to gap and slip.

    g = h - n_y delta + n_x U + N p - K^T q          gap, delta the normal approach, n the normal (out of the lower body)
    s = n_y U + n_x delta + K p - T q                slip of the upper face over the lower, U the tangential displacement
    P = n_y p + n_x q,   Q = n_y q - n_x p           what the upper body carries

p and q are nodal forces (pressure and shear times weight), p pressing and q along the tangent (n_y, -n_x) on the lower body.
N and T are symmetric, K couples: it is exactly zero for like bodies on matching meshes. On flat faces n = (0, 1).

`meshed_pair`, `condensed_pair` and `couple` make it from a scene: two bodies, meshed, condensed, facing each other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.mortar import Mortar, Side, mortar
from halfplane_fe.store import condensed
from meshes import BodyMesh, MeshSettings, SurfaceGrading, build
from scenes import Block, InputError, Pad, Scene, freeze

Array = NDArray[np.float64]

# The upper body's frame is reflected in y = 0: y points out of it.
_REFLECTED = np.array([1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Interface:
    """Compliance of a pair of bodies facing each other.

    Attributes
    ----------
    x, weights : (n,) contact points of the lower body and their share of the surface [length]
    normals : (2, n) n_x and n_y
    gap : (n,) initial distance of the faces, as they are made [length]
    normal, tangential : (n, n) N and T [length per force per thickness]
    coupling : (n, n) K, or None where it is exactly zero
    nearest : x and initial distance where the faces are nearest to each other [length]
    guided : whether this is one half of faces that p and q leave as mirror images (`mirror`): U is zero by symmetry, and so is Q
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

    @property
    def flat(self) -> bool:
        """Whether the normal is (0, 1) everywhere."""
        return not self.normals[0].any()

    def scaled(self, length: float, compliance: float) -> Interface:
        """The same interface in other units: lengths over `length`, compliances over `compliance`."""
        return replace(
            self,
            x=freeze(self.x / length),
            weights=freeze(self.weights / length),
            gap=freeze(self.gap / length),
            normal=freeze(self.normal / compliance),
            tangential=freeze(self.tangential / compliance),
            coupling=None if self.coupling is None else freeze(self.coupling / compliance),
            nearest=(self.nearest[0] / length, self.nearest[1] / length),
        )

    def moved(self, approach: float, shift: float) -> tuple[Array, Array]:
        """What normal approach and shift of the upper body add to gap and slip, each (n,)."""
        n_x, n_y = self.normals
        return n_x * shift - n_y * approach, n_y * shift + n_x * approach

    def carried(self, pressure: Array, shear: Array) -> tuple[float, float]:
        """P and Q that nodal forces p and q carry."""
        n_x, n_y = self.normals
        return float(n_y @ pressure + n_x @ shear), 0.0 if self.guided else float(n_y @ shear - n_x @ pressure)


def couple(lower: CondensedBody, upper: CondensedBody) -> Interface:
    """Couple two bodies: node by node where flat faces have nodes opposite each other, by mortar on their middle line elsewhere.

    The upper body is condensed in its own frame, as if it were a lower one, and reflected in y = 0 here.
    """
    if _opposite(lower, upper):
        # compliance[i, :, j, :]: displacement i (0 along x, 1 outward) by force j; the upper body feels -q along x and -p outward.
        below, above = lower.compliance, upper.compliance
        flat = np.stack([np.zeros_like(lower.x), np.ones_like(lower.x)])
        normal, tangential = (below[i, :, i, :] + above[i, :, i, :] for i in (1, 0))
        coupling = below[0, :, 1, :] - above[0, :, 1, :]
        weights, normals, gap, nearest = lower.weights, flat, np.zeros_like(lower.x), (0.0, 0.0)
    else:
        sides = _mortar(lower, upper)
        by_lower, by_upper = _flattened(sides.lower), _flattened(sides.upper)
        total = by_lower @ _square(lower.compliance) @ by_lower.T + by_upper @ _square(_turned(upper.compliance)) @ by_upper.T
        n = len(lower.x)
        normal, tangential, coupling = total[:n, :n], total[n:, n:], total[n:, :n]
        weights, normals, gap, nearest = sides.weights, sides.normals, sides.gap, sides.nearest
    return Interface(
        freeze(lower.x),
        freeze(weights),
        freeze(normals),
        freeze(gap),
        freeze(normal),
        freeze(tangential),
        freeze(coupling) if coupling.any() else None,
        nearest,
    )


# Nodes within which what only the mesh makes of N - T and K dies out, and those behind them whose mean is the plateau there.
_LOCAL, _PLATEAU = 8, (9, 10)
# Nodes of the contact side below which there is no such plateau.
_LEAST_NODES = 21


def without_local_difference(faces: Interface, scene: Scene) -> Interface | None:
    r"""The faces without the parts of N - T and of K that only the mesh makes; None where these can't be told from the bodies' own.

    On the smooth surface of an isotropic body a force displaces its surroundings by -(2/pi E') ln|x - x'| along itself, whether it
    presses or shears: N and T have one singular part, N - T is smooth, and K jumps at x = x', smooth on either side. On a mesh of
    quadratic elements they have parts of their own over the next nodes, the same for every size of element. N finds the nodes
    that touch, T the compliance of those that stick: the same set is longer for the one than for the other by a share of an
    element, and wherever edges move W has an error of first order. Here these parts go, T being what is changed:

        D_ij = (m_i + m_j)/2,   D = N - T,   |i - j| <= 8,   m_i the mean of D_ij at |i - j| = 9 and 10,

    and K likewise on each side of its diagonal, which is the mean of both. All that it takes from elasticity is that the singular
    parts are equal: that is imposed thereby, and not tested any more. Where ten nodes next to each other see the end of a face, or
    a base, N - T has parts that are not the mesh's.
    """
    n, apart, nodes = len(faces.x), np.diff(faces.x), max(_PLATEAU)
    depth = min(
        float(getattr(body, "height", getattr(body, "radius", np.inf))) for body in (scene.bodies.lower, scene.bodies.upper)
    )
    at_ends = face_room(scene) - float(np.abs(faces.x).max()) >= nodes * max(apart[0], apart[-1])
    if n < _LEAST_NODES or not at_ends or depth < 2 * nodes * float(apart.max()):
        return None
    ahead = np.subtract.outer(np.arange(n), np.arange(n))
    band = np.abs(ahead) <= _LOCAL
    tangential = np.where(band, faces.normal - _plateau(faces.normal - faces.tangential, np.abs(ahead)), faces.tangential)
    coupling = faces.coupling
    if coupling is not None:
        left, right = _plateau(coupling, ahead), _plateau(coupling, -ahead)
        smooth = np.where(ahead == 0, (left + right) / 2, np.where(ahead > 0, left, right))
        coupling = freeze(np.where(band, smooth, coupling))
    return replace(faces, tangential=freeze(tangential), coupling=coupling)


def _plateau(matrix: Array, ahead: NDArray[np.int64]) -> Array:
    """(n, n) means of the row and of the column of each entry over those 9 and 10 nodes ahead; their mean, or the one there is."""
    behind: NDArray[np.bool_] = np.isin(ahead, _PLATEAU)
    rows, columns = ((matrix * behind).sum(axis=axis) / np.maximum(behind.sum(axis=axis), 1) for axis in (1, 0))
    there = np.add.outer(np.any(behind, axis=1).astype(float), np.any(behind, axis=0).astype(float))  # the sums are 0 where none is
    return np.asarray(np.add.outer(rows, columns) / np.maximum(there, 1.0))


def body_forces(lower: CondensedBody, upper: CondensedBody, pressure: Array, shear: Array) -> dict[str, Array]:
    """Nodal forces (along x, outward) on each body in its own frame, "lower" and "upper", from nodal p and q.

    Parameters
    ----------
    pressure, shear : (n,) or (n, k) for k load cases [force per thickness]

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
    below, above = ((_flattened(part).T @ traction).reshape(2, -1, *cases) for part in (sides.lower, sides.upper))
    return {"lower": below, "upper": np.stack([-above[0], above[1]])}


def _opposite(lower: CondensedBody, upper: CondensedBody) -> bool:
    """Whether both faces are flat and have their nodes opposite each other."""
    flat = not (lower.y.any() or upper.y.any())
    return flat and lower.x.shape == upper.x.shape and bool(np.allclose(lower.x, upper.x, rtol=0, atol=1e-9 * np.ptp(lower.x)))


def _mortar(lower: CondensedBody, upper: CondensedBody) -> Mortar:
    return mortar(Side(lower.x, lower.y, lower.order), Side(upper.x, -upper.y, upper.order))


def _flattened(operator: Array) -> Array:
    """(2, n, 2, m) as a matrix (2 n, 2 m)."""
    return operator.reshape(2 * operator.shape[1], -1)


def _square(compliance: Array) -> Array:
    return compliance.reshape(2 * compliance.shape[1], -1)


def _turned(compliance: Array) -> Array:
    """A compliance of the upper body in the common frame."""
    return compliance * _REFLECTED[:, None, None, None] * _REFLECTED[:, None]


# Overlap of the faces as they are meshed that is admitted, over their largest gap: curved elements sag by a part of (h/a)^2 where
# the curvature of a face jumps.
_OVERLAP = 0.01
# The same over the width of the side that may touch, for faces without a gap: rounding.
_ROUNDING = 1e-9


def meshed_pair(scene: Scene, mesh: MeshSettings, grading: Callable[[float], SurfaceGrading]) -> tuple[BodyMesh, BodyMesh]:
    """Lower and upper body; one and the same where they have one shape and one element size.

    Parameters
    ----------
    grading : of a body whose elements are to be so many times as large
    """
    shapes = scene.bodies
    lower = build("lower", shapes.lower, scene.profile, grading(1.0), mesh)
    if shapes.lower == shapes.upper and mesh.upper_ratio == 1:
        return lower, lower
    return lower, build("upper", shapes.upper, scene.profile, grading(mesh.upper_ratio), mesh)


def condensed_pair(
    scene: Scene, bodies: tuple[BodyMesh, BodyMesh], datum_length: float, work: Counter[str]
) -> tuple[CondensedBody, CondensedBody]:
    """Both bodies condensed, from the store where they are there; `work` counts."""
    lower = condensed(bodies[0], scene.material.lower, datum_length, work)
    if scene.material.alike and bodies[1] is bodies[0]:
        return lower, lower
    return lower, condensed(bodies[1], scene.material.upper, datum_length, work)


def initial_gap(scene: Scene, interface: Interface) -> Array:
    """(n,) initial gap in the units of the scene's lengths: that of the faces as made, or the profile between two flat ones.

    Raises
    ------
    InputError
        If the faces overlap before any load.
    """
    if not scene.bodies.faces_are_true:
        return np.asarray(scene.profile.height(interface.x))
    x, distance = interface.nearest
    if -distance > max(_OVERLAP * float(interface.gap.max()), _ROUNDING * float(np.ptp(interface.x))):
        raise InputError(f"bodies: initial penetration: the faces overlap by {-distance:.6g} at x = {x:.6g}")
    return interface.gap


def check_supports(scene: Scene, sheared: bool) -> None:
    """Refuse bodies that a tangential load would push off their supports.

    Raises
    ------
    InputError
        For a block or pad on rollers with free sides under a tangential load.
    """
    for name, body in (("lower", scene.bodies.lower), ("upper", scene.bodies.upper)):
        if sheared and isinstance(body, Block | Pad) and body.base == "rollers" and body.sides == "free":
            raise InputError(
                f"bodies.{name}: nothing holds the {body.kind} against the tangential load, it slides off: its base is on "
                "rollers and its sides are free; take base = 'fixed' or sides = 'guided'"
            )


def face_room(scene: Scene) -> float:
    """Half the width of the narrower face [length]; infinite for half-planes."""
    return min(scene.bodies.lower.face_half_width, scene.bodies.upper.face_half_width)


def shapes_alike(scene: Scene) -> bool:
    """Whether the two bodies are each other's mirror image, materials included."""
    return scene.material.alike and scene.bodies.lower == scene.bodies.upper
