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
from typing import NamedTuple

import numpy as np

from halfplane_fe.contact import InterfaceState
from halfplane_fe.interface import Interface
from halfplane_fe.run import PathRun
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, freeze
from scenes.array_types import Array, Indices

# By how much a face and its image may differ, over the largest entry: rounding of the condensation.
_ALIKE = 1e-9


def mirrored(faces: Interface, sheared: bool) -> bool:
    """Whether a node lies on x = 0, and the answer on these faces is its own mirror image in it.

    `sheared`: there is a tangential load. Coupled faces under shear have no mirror image; uncoupled
    ones need flat faces.
    """
    if len(faces.x) % 2 == 0:
        return False
    if faces.coupling is None and not faces.flat:
        return False
    if faces.coupling is not None and sheared:
        return False
    values_and_images = [
        (faces.x, -faces.x[::-1]),
        (faces.weights, faces.weights[::-1]),
        (faces.gap, faces.gap[::-1]),
        (faces.normals[0], -faces.normals[0, ::-1]),
        (faces.normals[1], faces.normals[1, ::-1]),
        (faces.normal, faces.normal[::-1, ::-1]),
        (faces.tangential, faces.tangential[::-1, ::-1]),
    ]
    if faces.coupling is not None:
        values_and_images.append((faces.coupling, -faces.coupling[::-1, ::-1]))
    return all(
        bool(np.abs(values - image).max() <= _ALIKE * np.abs(values).max())
        for values, image in values_and_images
    )


def half(faces: Interface) -> Interface:
    """The interface on x >= 0 of faces whose answer is its own mirror image: nodal forces are those
    of a node and its image together. Where normal and tangential forces are coupled, q is odd, so U
    and Q are zero.
    """
    right_half = slice(len(faces.x) // 2, None)
    is_coupled = faces.coupling is not None
    parity_of_shear = -1.0 if is_coupled else 1.0
    tangential_compliance = _folded(faces.tangential, parity_of_shear, parity_of_shear)
    if is_coupled:  # an odd q is zero in the middle
        tangential_compliance[0, 0] = faces.tangential.diagonal().max()
    return replace(
        faces,
        x=freeze(faces.x[right_half]),
        weights=freeze(np.bincount(_images(faces).place, faces.weights)),
        normals=freeze(faces.normals[:, right_half]),
        gap=freeze(faces.gap[right_half]),
        imposed=None,
        normal=freeze(_folded(faces.normal, 1.0, 1.0)),
        tangential=freeze(tangential_compliance),
        coupling=freeze(_folded(faces.coupling, -1.0, 1.0)) if faces.coupling is not None else None,
        guided=is_coupled,
    )


class _Images(NamedTuple):
    """How the n nodes of the faces follow from those of the right half.

    Attributes
    ----------
    place
        (n,) of each node in the right half
    share
        (n,) of that node's p
    sign
        (n,) of its q and slip
    """

    place: Indices
    share: Array
    sign: Array


def _images(faces: Interface) -> _Images:
    number = np.arange(len(faces.x)) - len(faces.x) // 2
    odd_shear = faces.coupling is not None
    return _Images(
        place=np.abs(number),
        share=np.where(number == 0, 1.0, 0.5),
        sign=np.where((number < 0) & odd_shear, -1.0, 1.0),
    )


def _folded(matrix: Array, parity_of_rows: float, parity_of_columns: float) -> Array:
    """S^T M S, (m, m), of a matrix M (n, n) over nodes and their mirror images, with functions of
    rows and of columns that are even, 1, or odd, -1, on the right half.
    """
    middle = len(matrix) // 2
    folded_rows = (
        matrix[middle:] + parity_of_rows * matrix[middle::-1]
    ) / 2  # the middle is its own image
    return np.asarray(
        (folded_rows[:, middle:] + parity_of_columns * folded_rows[:, middle::-1]) / 2
    )


def unfolded(run: PathRun, faces: Interface) -> PathRun:
    """A run that was solved on the right half of mirrored faces, as a run on all their nodes:
    values and states of the left half are the mirror images.
    """
    images = _images(faces)
    n_half = len(faces.x) - len(faces.x) // 2
    # Of each value of a state its place in that of the half, and what it is there times.
    numbers_in_half = [3 + images.place + number * n_half for number in range(4)]
    number_in_half = np.concatenate([np.arange(3), *numbers_in_half])
    sign_of_slip = images.sign
    factor_of_shear = images.share * images.sign
    factors = np.concatenate(
        [np.ones(3), sign_of_slip, images.share, factor_of_shear, np.ones_like(images.share)]
    )
    states_of_image = np.array([OPEN, STICK, SLIP_REVERSE, SLIP_FORWARD], dtype=np.int8)

    def unfolded_state(state: InterfaceState) -> InterfaceState:
        n_values = len(number_in_half) if state.is_complete else 3 + len(images.place)
        values = state.values[number_in_half[:n_values]] * factors[:n_values]
        values.flags.writeable = False
        states = state.state[images.place]
        states = np.where(images.sign < 0, states_of_image[states], states)
        return replace(state, values=values, state=freeze(states, np.int8))

    return replace(
        run,
        states=[unfolded_state(state) for state in run.states],
        cycle_density=[density[images.place] * images.share for density in run.cycle_density],
    )
