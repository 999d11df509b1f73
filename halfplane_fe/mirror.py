r"""Faces that are their own mirror image, solved on one half and written out on both.

Where nothing couples p and q, both are even in x at every instant: the problem has one answer and its mirror image is another. With
F_k the force on a node and its image together, S the matrix that shares it (1/2 and 1/2; 1 in the middle), f = S F,

    N F -> S^T N S F,   sum f = sum F,   gap and slip those of either node,

so that the same contact problem is solved with half the nodes, a quarter of the numbers in each matrix.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import InterfaceState
from halfplane_fe.energy import IncrementEnergy
from halfplane_fe.interface import Interface
from halfplane_fe.run import PathRun
from scenes import freeze

Array = NDArray[np.float64]

# By how much a face and its image may differ, over the largest entry: rounding of the condensation.
_ALIKE = 1e-9


def mirrored(faces: Interface) -> bool:
    """Whether the faces are their own mirror image in x = 0, with a node there, and nothing couples p and q."""
    odd = len(faces.x) % 2 == 1
    if faces.coupling is not None or not faces.flat or not odd:
        return False
    pairs = [(faces.x, -faces.x[::-1]), (faces.weights, faces.weights[::-1]), (faces.gap, faces.gap[::-1])]
    pairs += [(matrix, matrix[::-1, ::-1]) for matrix in (faces.normal, faces.tangential)]
    return all(bool(np.abs(one - image).max() <= _ALIKE * np.abs(one).max()) for one, image in pairs)


def half(faces: Interface) -> Interface:
    """The faces on x >= 0, forces being those of a node and its image together."""
    place, _ = _images(len(faces.x))
    right = slice(len(faces.x) // 2, None)
    return Interface(
        freeze(faces.x[right]),
        freeze(np.bincount(place, faces.weights)),
        freeze(faces.normals[:, right]),
        freeze(faces.gap[right]),
        freeze(_folded(faces.normal)),
        freeze(_folded(faces.tangential)),
        None,
    )


def _images(n: int) -> tuple[NDArray[np.int64], Array]:
    """Of each of n nodes in ascending order its place in the right half, and its share of that node's force."""
    place = np.abs(np.arange(n) - n // 2)
    return place, np.where(place == 0, 1.0, 0.5)


def _folded(matrix: Array) -> Array:
    """S^T M S."""
    middle = len(matrix) // 2
    rows = (matrix[middle:] + matrix[middle::-1]) / 2  # the middle is its own image
    return np.asarray((rows[:, middle:] + rows[:, middle::-1]) / 2)


def whole(run: PathRun, n: int) -> PathRun:
    """A run of the half on all n nodes."""
    place, share = _images(n)

    def state(one: InterfaceState) -> InterfaceState:
        found = replace(one, slip=freeze(one.slip[place]), state=freeze(one.state[place], np.int8))
        if not len(one.pressure):  # dropped
            return found
        pressure, shear, gap = (
            freeze(values) for values in (one.pressure[place] * share, one.shear[place] * share, one.gap[place])
        )
        return replace(found, pressure=pressure, shear=shear, gap=gap)

    def energy(one: IncrementEnergy) -> IncrementEnergy:
        nodal = one.dissipation
        return one if len(nodal) == 1 else replace(one, dissipation=nodal[place] * share)

    return replace(
        run,
        states=[state(one) for one in run.states],
        energies=[energy(one) for one in run.energies],
        cycle_density=[density[place] * share for density in run.cycle_density],
    )
