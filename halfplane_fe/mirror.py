r"""Contact that is its own mirror image in x = 0: solved on the nodes at x >= 0, then continued to
all nodes.

Where the load path and the faces are their own mirror image in x = 0, so is the answer: p is even
in x. So is q where nothing couples the two; without a tangential load q is odd, an effect of p
alone, and U = 0. F_k is the force on a node and its image together. The matrix S shares it between
both (1/2 and +-1/2; in the middle 1, or 0 of an odd q): f = S F are the forces at all nodes. With N
a compliance matrix,

    N F -> S^T N S F,   sum f = sum F,   gap and slip those of the node with x > 0,

so that the same contact problem is solved with half the nodes, a quarter of the numbers in each
matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from halfplane_fe.contact import InterfaceState
from halfplane_fe.interface import Interface
from halfplane_fe.run import PathRun
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, read_only_copy
from scenes.array_types import Array, Indices

# Largest difference of a compliance and its mirror image, over the largest entry: round-off of the
# condensation.
_MIRROR_ROUNDING = 1e-9


def is_mirrored(faces: Interface, has_tangential_load: bool) -> bool:
    """Whether the solution of a contact problem is its own mirror image in x = 0, so that one half
    of the nodes is enough.

    A node has to lie on x = 0, and places, gap and compliances have to be mirror images, to 1e-9 of
    their largest value. Where pressure and shear are coupled (unlike bodies), there must be no
    tangential load. Where they are not coupled, the faces must be flat.

    Parameters
    ----------
    faces
        the contact compliance: places x (n,) of the nodes, lengths of face, gap, normals (2, n),
        normal and tangential compliance and coupling (n, n); the latter None where pressure and
        shear are not coupled
    has_tangential_load
        whether a tangential load other than 0 is on the load path
    """
    if len(faces.x) % 2 == 0:
        return False
    if faces.coupling is None and not faces.is_flat:
        return False
    if faces.coupling is not None and has_tangential_load:
        return False
    values_and_images = [
        (faces.x, -faces.x[::-1]),
        (faces.face_lengths, faces.face_lengths[::-1]),
        (faces.gap, faces.gap[::-1]),
        (faces.face_normals[0], -faces.face_normals[0, ::-1]),
        (faces.face_normals[1], faces.face_normals[1, ::-1]),
        (faces.normal_compliance, faces.normal_compliance[::-1, ::-1]),
        (faces.tangential_compliance, faces.tangential_compliance[::-1, ::-1]),
    ]
    if faces.coupling is not None:
        values_and_images.append((faces.coupling, -faces.coupling[::-1, ::-1]))
    return all(
        bool(np.abs(values - image).max() <= _MIRROR_ROUNDING * np.abs(values).max())
        for values, image in values_and_images
    )


def half_interface(faces: Interface) -> Interface:
    """Contact compliance of mirror-symmetric bodies, reduced to the nodes at x >= 0, for a solution
    that is its own mirror image in x = 0.

    A nodal force then is that of a node and its image together. Where pressure and shear are
    coupled (unlike bodies), q is odd in x. Then the tangential load and the tangential displacement
    are zero (`has_odd_shear` of what is returned). Elsewhere q is even.

    `faces` is the contact compliance of all nodes: their places x, lengths of face, gap, normals
    (2, n), normal and tangential compliance (n, n), and coupling (n, n), None where pressure and
    shear are not coupled.
    """
    # `node_of_half` below: index of each node, or of its image, among those at x >= 0
    right_half = slice(len(faces.x) // 2, None)
    is_coupled = faces.coupling is not None
    parity_of_shear = -1.0 if is_coupled else 1.0
    # `_folded` reduces a matrix to the nodes at x >= 0, by the parity (1 even, -1 odd) of its rows
    # and of its columns in x
    folded_tangential_compliance = _folded(
        faces.tangential_compliance, parity_of_shear, parity_of_shear
    )
    if is_coupled:
        # An odd q is zero at x = 0: its row and column are zero, and any positive number serves.
        folded_tangential_compliance[0, 0] = faces.tangential_compliance.diagonal().max()
    return replace(
        faces,
        x=read_only_copy(faces.x[right_half]),
        face_lengths=read_only_copy(np.bincount(_images(faces).node_of_half, faces.face_lengths)),
        face_normals=read_only_copy(faces.face_normals[:, right_half]),
        gap=read_only_copy(faces.gap[right_half]),
        gap_and_slip_per_stress_and_tilt=None,
        normal_compliance=read_only_copy(_folded(faces.normal_compliance, 1.0, 1.0)),
        tangential_compliance=read_only_copy(folded_tangential_compliance),
        coupling=read_only_copy(_folded(faces.coupling, -1.0, 1.0))
        if faces.coupling is not None
        else None,
        has_odd_shear=is_coupled,
    )


class _Images(NamedTuple):
    """How values at all n nodes follow from those at the nodes with x >= 0.

    Attributes
    ----------
    node_of_half
        (n,) index of each node, or of its mirror image, among the nodes with x >= 0
    force_share
        (n,) part of that node's force: 1/2, at x = 0 1
    shear_sign
        (n,) factor on that node's q and slip: -1 at x < 0 where they are odd, else 1
    """

    node_of_half: Indices
    force_share: Array
    shear_sign: Array


def _images(faces: Interface) -> _Images:
    """How values at all n nodes of a contact follow from those at the nodes with x >= 0. For each
    node: index of it or its image among these, share of the force there, and sign of its shear and
    slip.
    """
    nodes_from_middle = np.arange(len(faces.x)) - len(faces.x) // 2
    has_odd_shear = faces.coupling is not None
    return _Images(
        node_of_half=np.abs(nodes_from_middle),
        force_share=np.where(nodes_from_middle == 0, 1.0, 0.5),
        shear_sign=np.where((nodes_from_middle < 0) & has_odd_shear, -1.0, 1.0),
    )


def _folded(matrix: Array, parity_of_rows: float, parity_of_columns: float) -> Array:
    """Reduce a matrix over n nodes, symmetric about x = 0, to the m nodes at x >= 0: (m, m).

    With M the matrix it is S^T M S. S continues values on the right half to the left one, as an
    even function (parity 1) or an odd one (parity -1), and halves them. Rows and columns each have
    their parity.
    """
    middle = len(matrix) // 2  # of the node at x = 0, which is its own image
    folded_rows = (matrix[middle:] + parity_of_rows * matrix[middle::-1]) / 2
    return np.asarray(
        (folded_rows[:, middle:] + parity_of_columns * folded_rows[:, middle::-1]) / 2
    )


def _states_at_all_nodes(
    contact_states: Sequence[InterfaceState], images: _Images
) -> list[InterfaceState]:
    """Contact states at all n nodes of mirror-symmetric faces, from those at the nodes with x >= 0;
    without forces and gap where a long run has dropped them.

    The values of a state are approach, tangential displacement and tilt, then slip, p, q and gap of
    the nodes. `images` holds for each of the n nodes:

    - `node_of_half`: the index of it or its image among the solved nodes
    - `force_share`: its share of the force there, 1/2, or 1 at x = 0
    - `shear_sign`: the sign of its slip and q
    """
    # For each value at all nodes, its index among the values at the solved nodes.
    n_nodes_of_half = int(images.node_of_half.max()) + 1
    nodal_indices = [3 + images.node_of_half + quantity * n_nodes_of_half for quantity in range(4)]
    index_in_half = np.concatenate([np.arange(3), *nodal_indices])
    # Factors of approach, displacement and tilt, then of slip, p, q and gap.
    factors = np.concatenate(
        [
            np.ones(3),
            images.shear_sign,
            images.force_share,
            images.force_share * images.shear_sign,
            np.ones_like(images.force_share),
        ]
    )
    # by node state: open, stick, and slip in the opposite sense
    image_of_node_state = np.array([OPEN, STICK, SLIP_REVERSE, SLIP_FORWARD], dtype=np.int8)

    def at_all_nodes(contact_state: InterfaceState) -> InterfaceState:
        """One contact state at all n nodes, from that at the nodes with x >= 0. The values of a
        state are approach, tangential displacement, tilt, and slip, p, q, gap of the nodes.

        Each value at all nodes is the value of number `index_in_half` in the half, times its
        `factors`. A state that is not complete ends with the slip. Node states are those of the
        image; at x < 0 slip has the opposite sense (`image_of_node_state`) if shear is odd in x.
        """
        n_values = len(index_in_half) if contact_state.is_complete else 3 + len(images.node_of_half)
        values_at_all_nodes = contact_state.values[index_in_half[:n_values]] * factors[:n_values]
        values_at_all_nodes.flags.writeable = False
        node_states_at_all = contact_state.node_states[images.node_of_half]
        node_states_at_all = np.where(
            images.shear_sign < 0, image_of_node_state[node_states_at_all], node_states_at_all
        )
        return replace(
            contact_state,
            values=values_at_all_nodes,
            node_states=read_only_copy(node_states_at_all, np.int8),
        )

    return [at_all_nodes(contact_state) for contact_state in contact_states]


def run_at_all_nodes(run: PathRun, faces: Interface) -> PathRun:
    """Solution along a load path at all nodes of `faces`, from a `run` that was solved on those at
    x >= 0: the left half is the mirror image.

    In the solution on one half p and q of a node are the forces of it and its image together. So
    each of the two gets half of them, but the node at x = 0 gets all. Slip and q change sign at
    x < 0 where they are odd in x. Friction work is shared like the forces.

    Parameters
    ----------
    run
        contact states; friction work of the nodes in each cycle; error of that work, with the
        permanent stick zone (`edge_excess_by_cycle`); edges that the loads locate between nodes
    faces
        contact compliance of all n nodes
    """
    images = _images(faces)
    middle_node = len(faces.x) // 2  # number of the node at x = 0
    return replace(
        run,
        states=_states_at_all_nodes(run.states, images),
        nodal_work_by_cycle=[
            work[images.node_of_half] * images.force_share for work in run.nodal_work_by_cycle
        ],
        edge_excess_by_cycle=[
            edge_excess._replace(stick_zone=edge_excess.stick_zone.mirrored())
            for edge_excess in run.edge_excess_by_cycle
        ],
        contact_edges=[edges.mirrored(middle_node) for edges in run.contact_edges],
        stick_edges=[edges.mirrored(middle_node) for edges in run.stick_edges],
    )
