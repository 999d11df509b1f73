r"""Faces that are their own mirror image, solved on one half and written out on both.

Where the load path and the faces are their own mirror image in x = 0, so is the answer: p is even
in x. So is q where nothing couples the two; without a tangential load q is odd, pressed out of p
alone, and U = 0. With F_k the force on a node and its image together, S the matrix that shares it
(1/2 and +-1/2; in the middle 1, or 0 of an odd q), f = S F,

    N F -> S^T N S F,   sum f = sum F,   gap and slip those of the node with x > 0,

so that the same contact problem is solved with half the nodes, a quarter of the numbers in each
matrix.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from halfplane_fe.arrays import Array, Indices
from halfplane_fe.contact import InterfaceState
from halfplane_fe.interface import Interface
from halfplane_fe.run import PathRun
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, freeze

# By how much a face and its image may differ, over the largest entry: rounding of the condensation.
_ALIKE = 1e-9


def mirrored(faces: Interface, sheared: bool) -> bool:
    """Whether the answer is its own mirror image in x = 0, and a node lies there; `sheared`:
    whether there is a tangential load.
    """
    if (
        len(faces.x) % 2 == 0
        or (faces.coupling is None and not faces.flat)
        or (faces.coupling is not None and sheared)
    ):
        return False
    pairs = [
        (faces.x, -faces.x[::-1]),
        (faces.weights, faces.weights[::-1]),
        (faces.gap, faces.gap[::-1]),
    ]
    pairs += [
        (faces.normals[0], -faces.normals[0, ::-1]),
        (faces.normals[1], faces.normals[1, ::-1]),
    ]
    pairs += [(matrix, matrix[::-1, ::-1]) for matrix in (faces.normal, faces.tangential)]
    if faces.coupling is not None:
        pairs.append((faces.coupling, -faces.coupling[::-1, ::-1]))
    return all(
        bool(np.abs(one - image).max() <= _ALIKE * np.abs(one).max()) for one, image in pairs
    )


def half(faces: Interface) -> Interface:
    """The faces on x >= 0, forces being those of a node and its image together."""
    place, _, _ = _images(faces)
    right = slice(len(faces.x) // 2, None)
    coupled = faces.coupling is not None
    tangential = _folded(faces.tangential, -1.0 if coupled else 1.0, -1.0 if coupled else 1.0)
    if coupled:  # an odd q is zero in the middle
        tangential[0, 0] = faces.tangential.diagonal().max()
    return replace(
        faces,
        x=freeze(faces.x[right]),
        weights=freeze(np.bincount(place, faces.weights)),
        normals=freeze(faces.normals[:, right]),
        gap=freeze(faces.gap[right]),
        imposed=None,
        normal=freeze(_folded(faces.normal, 1.0, 1.0)),
        tangential=freeze(tangential),
        coupling=freeze(_folded(faces.coupling, -1.0, 1.0)) if faces.coupling is not None else None,
        guided=coupled,
    )


def _images(faces: Interface) -> tuple[Indices, Array, Array]:
    """Of each node in ascending order its place in the right half, its share of that node's p, and
    the sign of its q.
    """
    number = np.arange(len(faces.x)) - len(faces.x) // 2
    odd = faces.coupling is not None
    return np.abs(number), np.where(number == 0, 1.0, 0.5), np.where((number < 0) & odd, -1.0, 1.0)


def _folded(matrix: Array, of_rows: float, of_columns: float) -> Array:
    """S^T M S, rows and columns even (1) or odd (-1)."""
    middle = len(matrix) // 2
    rows = (matrix[middle:] + of_rows * matrix[middle::-1]) / 2  # the middle is its own image
    return np.asarray((rows[:, middle:] + of_columns * rows[:, middle::-1]) / 2)


def whole(run: PathRun, faces: Interface) -> PathRun:
    """A run of the half on all nodes of the faces."""
    place, share, sign = _images(faces)
    half = len(faces.x) - len(faces.x) // 2
    # Of each value of a state in the whole its place in the half, and what it is there times.
    source = np.concatenate([np.arange(3), *(3 + place + number * half for number in range(4))])
    factor = np.concatenate([np.ones(3), sign, share, share * sign, np.ones_like(share)])
    turned = np.array([OPEN, STICK, SLIP_REVERSE, SLIP_FORWARD], dtype=np.int8)

    def state(one: InterfaceState) -> InterfaceState:
        size = len(source) if one.whole else 3 + len(place)
        values, states = one.values[source[:size]] * factor[:size], one.state[place]
        values.flags.writeable = False
        return replace(
            one, values=values, state=freeze(np.where(sign < 0, turned[states], states), np.int8)
        )

    densities = [density[place] * share for density in run.cycle_density]
    return replace(run, states=[state(one) for one in run.states], cycle_density=densities)
