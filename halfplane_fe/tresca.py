"""The two halves of the contact problem on their own, each convex, each solved from any start.

Unilateral contact at known shear, and friction at known pressure (Tresca's law, |q| <= f p with p
given).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
import scipy
from scipy.linalg import solve

from halfplane_fe.systems import SingularSet, Systems
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, ConvergenceError
from scenes.array_types import Array, Mask, States

# Active sets of these convex problems end within ten or so; sets that recur take a node a step.
_MOST_ITERATIONS = 200

NodeSet = TypeVar("NodeSet", Mask, States)
Forces = TypeVar("Forces")


class _NormalForces(NamedTuple):
    """Nodal normal forces p (n,) and the normal approach delta."""

    normal_forces: Array
    approach: float


def pressure_at_known_shear(
    systems: Systems, initial_gap: Array, normal_load: float, is_closed: Mask, round_off: float
) -> tuple[Array, float, Mask]:
    """Unilateral contact under a given `normal_load`, the tangential forces being known: nodal
    normal forces p (n,), normal approach delta, and which nodes touch. Active-set method.

    With the gap g = initial_gap - n_y delta + N p:   g >= 0, p >= 0, g p = 0, and the sum of n_y p
    is the normal load.

    # notation: N normal compliance of `systems`, n_y component of the faces' normal along y

    Parameters
    ----------
    systems
        compliances of the contact nodes
    initial_gap
        (n,) initial gap, with what known tangential forces and displacement add to it
    normal_load
        load that the nodal normal forces carry, in their scaled units: P minus what the known
        tangential forces carry on an inclined face
    is_closed
        (n,) nodes that are assumed to touch first
    round_off
        size of a negative p or g that counts as round-off

    Raises
    ------
    SingularSet
        If no node is left that touches.
    ConvergenceError
        If the set of touching nodes does not converge.

    Examples
    --------
    >>> from halfplane_fe.interface import Interface
    >>> from halfplane_fe.systems import Layer
    >>> springs, zeros = np.eye(2), np.zeros(2)  # two nodes, each on a spring of its own
    >>> flat = Interface(
    ...     np.array([0.0, 1.0]),
    ...     np.ones(2),
    ...     np.array([[0.0, 0.0], [1.0, 1.0]]),
    ...     zeros,
    ...     springs,
    ...     springs,
    ...     None,
    ... )
    >>> initial_gap, start = np.array([0.0, 1.0]), np.array([True, False])
    >>> pressure, approach, closed = pressure_at_known_shear(
    ...     Systems(flat, Layer(zeros, zeros), 0.5), initial_gap, 3.0, start, 1e-12
    ... )
    >>> pressure.tolist(), approach, closed.tolist()  # approach 2, the second node meets after 1
    ([2.0, 1.0], 2.0, [True, True])
    """

    n_y = systems.interface.face_normals[1]

    def normal_step(is_closed: Mask) -> tuple[_NormalForces, Array, Mask]:
        """Normal forces p and approach delta for a set of closed nodes; by how much each of n nodes
        violates p >= 0 (closed) or g >= 0 (open); and the next set, in which such nodes have
        opened or closed.

        The gap g = `initial_gap` - n_y delta + N p is 0 at the closed nodes, N being the normal
        compliance of `systems`; n_y p adds up to `normal_load`. Less than `round_off` is no
        violation.
        """
        if not is_closed.any():
            raise SingularSet("no node holds the normal load")

        # Normal forces of the closed nodes: p that closes the initial gaps without approach, and p
        # by a unit of approach.
        force_by_gap, force_by_approach = solve(
            systems.normal_compliance[np.ix_(is_closed, is_closed)],
            np.stack([-initial_gap[is_closed], n_y[is_closed]], axis=1),
            assume_a="pos",
        ).T
        approach = (normal_load - n_y[is_closed] @ force_by_gap) / (
            n_y[is_closed] @ force_by_approach
        )
        normal_forces = np.zeros_like(initial_gap)
        normal_forces[is_closed] = force_by_gap + approach * force_by_approach

        # Violations of the laws.
        gap = initial_gap - n_y * approach + systems.normal_compliance @ normal_forces
        violation = np.where(is_closed, -normal_forces, -gap)
        is_closed_next = np.where(violation > round_off, ~is_closed, is_closed)
        return _NormalForces(normal_forces, float(approach)), violation, is_closed_next

    forces, is_closed = _forces_by_active_set(normal_step, is_closed)
    return forces.normal_forces, forces.approach, is_closed


def shear_at_known_pressure(
    systems: Systems,
    pressure: Array,
    slip_deficit: Array,
    tangential_load: float | None,
    round_off: float,
) -> tuple[Array, float, States]:
    """Friction at known normal forces (Tresca): nodal tangential forces q (n,), tangential
    displacement U, and the nodes' states open, stick or slip.

    With the slip increment s = n_y U - T q - slip_deficit:   |q| <= f p, s = 0 where |q| < f p,
    else s along q, and the sum of n_y q is the tangential load. The sum grows with U from -f P to f
    P, so that U is found by bracketing.

    # notation: T tangential compliance of `systems`, n_y component of the faces' normal along y,
    # f coefficient of friction

    Parameters
    ----------
    systems
        compliances of the contact nodes, and f
    pressure
        (n,) known nodal normal forces p
    slip_deficit
        (n,) slip at the start of the increment minus that at its end by known causes: p, bulk
        stresses and tilt
    tangential_load
        scaled, below f times the sum of p; None where U = 0 is prescribed instead
    round_off
        size of a violation that counts as round-off

    Raises
    ------
    ConvergenceError
        If the states of the nodes do not converge, or a tangential load has no pressed node.

    Examples
    --------
    >>> from halfplane_fe.interface import Interface
    >>> from halfplane_fe.systems import Layer
    >>> springs, zeros = np.eye(2), np.zeros(2)  # two nodes, each on a spring of its own
    >>> flat = Interface(
    ...     np.array([0.0, 1.0]),
    ...     np.ones(2),
    ...     np.array([[0.0, 0.0], [1.0, 1.0]]),
    ...     zeros,
    ...     springs,
    ...     springs,
    ...     None,
    ... )
    >>> systems, pressure = Systems(flat, Layer(zeros, zeros), 0.5), np.array([0.2, 1.0])
    >>> shear, displacement, states = shear_at_known_pressure(systems, pressure, zeros, 0.5, 1e-12)
    >>> (
    ...     shear.round(12).tolist(),
    ...     round(displacement, 12),
    ...     states.tolist(),
    ... )  # the first node slips at f p = 0.1, the second holds the rest
    ([0.1, 0.4], 0.4, [2, 1])
    >>> shear_at_known_pressure(systems, zeros, zeros, 0.5, 1e-12)
    Traceback (most recent call last):
    ...
    scenes.errors.ConvergenceError: contact: no node is pressed, so none can carry shear
    """
    n_y = systems.interface.face_normals[1]
    coulomb_limit = systems.friction * pressure  # f p
    is_closed = pressure > 0
    # function of U: tangential forces (n,) at that displacement; it keeps the states of the nodes
    shear_at = _ShearAtDisplacement(
        systems=systems,
        coulomb_limit=coulomb_limit,
        slip_deficit=slip_deficit,
        round_off=round_off,
        node_states=np.where(is_closed, STICK, OPEN).astype(np.int8),
    )
    if tangential_load is None:
        return shear_at(0.0), 0.0, shear_at.node_states

    if not is_closed.any():
        raise ConvergenceError("contact: no node is pressed, so none can carry shear")

    # U is found between two displacements at which all nodes slide one way or the other.
    largest_slip_at_limit = np.abs(systems.tangential_compliance @ coulomb_limit)[is_closed].max()
    largest_displacement = (
        np.abs(slip_deficit[is_closed]).max() + largest_slip_at_limit
    ) / n_y.min()

    def excess_load(displacement: float) -> float:
        """Tangential load at a displacement U, minus the given one."""
        return float(n_y @ shear_at(displacement)) - tangential_load

    # xtol below the round-off of U; rtol is the least that brentq takes.
    tolerance = 1e-13 * max(largest_displacement, 1e-300)
    displacement = scipy.optimize.brentq(
        excess_load, -largest_displacement, largest_displacement, xtol=tolerance, rtol=8.9e-16
    )
    return shear_at(float(displacement)), float(displacement), shear_at.node_states


@dataclass(eq=False)
class _ShearAtDisplacement:
    """Nodal tangential forces q (n,) as a function of the tangential displacement U; each solve
    starts from the node states at which the one before ended.

    Attributes
    ----------
    systems
        compliances of the contact nodes
    coulomb_limit
        (n,) f p of the nodes
    slip_deficit
        (n,) slip that is subtracted from n_y U - T q, T the tangential compliance
    round_off
        size of a violation that counts as round-off
    node_states
        (n,) open, stick or slip of the last solve
    """

    systems: Systems
    coulomb_limit: Array
    slip_deficit: Array
    round_off: float
    node_states: States

    def __call__(self, displacement: float) -> Array:
        """Nodal tangential forces q (n,) within the limits of friction at a tangential displacement
        U; `node_states` become those there.

        `coulomb_limit` (n,) is f p of the nodes. The slip increment is n_y U - T q -
        `slip_deficit`, n_y the component along y of the faces' normal, T the tangential compliance
        of `systems`.
        """
        n_y = self.systems.interface.face_normals[1]
        deficit_at_displacement = self.slip_deficit - n_y * displacement
        tangential_forces, self.node_states = _shear_within_limits(
            self.systems,
            self.coulomb_limit,
            deficit_at_displacement,
            self.node_states,
            self.round_off,
        )
        return tangential_forces


def _shear_within_limits(
    systems: Systems,
    coulomb_limit: Array,
    slip_deficit: Array,
    node_states: States,
    round_off: float,
) -> tuple[Array, States]:
    """Friction with known limits |q| <= f p at a known tangential displacement (Tresca): nodal
    tangential forces q (n,) and the nodes' states open, stick or slip, scaled.

    Active-set method, from given `node_states`. With the slip increment s = -T q - slip_deficit:
    s = 0 where |q| < f p, s >= 0 at q = f p, s <= 0 at q = -f p. T is the tangential compliance
    `systems.tangential_compliance`.

    Parameters
    ----------
    systems
        compliances of the contact nodes
    coulomb_limit
        (n,) f p of the nodes
    slip_deficit
        (n,) slip at the start of the increment minus that at its end by all but q
    node_states
        (n,) open, stick or slip at the start of the iteration; open nodes stay open
    round_off
        size of a violation that counts as round-off
    """

    def friction_step(trial_states: States) -> tuple[Array, Array, States]:
        """For trial states (n,) of the nodes: tangential forces q; by how much each node violates
        its inequality; and the next states.

        Sticking nodes have no slip increment, s = -T q - `slip_deficit` = 0, T being the tangential
        compliance of `systems`; sliding ones are at the Coulomb limit, q = +-f p (`coulomb_limit`).
        The inequality of a sticking node is |q| <= f p, that of a sliding one slip along q.
        """
        is_sticking = trial_states == STICK
        slips_forward = trial_states == SLIP_FORWARD
        slips_back = trial_states == SLIP_REVERSE
        # q of sliding nodes is known; that of sticking ones leaves them without slip
        tangential_forces = coulomb_limit * slips_forward - coulomb_limit * slips_back
        if is_sticking.any():
            slip_to_cancel = (-slip_deficit - systems.tangential_compliance @ tangential_forces)[
                is_sticking
            ]
            tangential_forces[is_sticking] = solve(
                systems.tangential_compliance[np.ix_(is_sticking, is_sticking)],
                slip_to_cancel,
                assume_a="pos",
            )
        slip_increment = -systems.tangential_compliance @ tangential_forces - slip_deficit

        violation = np.full(len(slip_increment), -np.inf)  # an open node has no inequality
        violation[is_sticking] = (np.abs(tangential_forces) - coulomb_limit)[is_sticking]
        violation[slips_forward] = -slip_increment[slips_forward]
        violation[slips_back] = slip_increment[slips_back]
        slip_states = np.where(tangential_forces > 0, SLIP_FORWARD, SLIP_REVERSE)
        other_states = np.where(is_sticking, slip_states, STICK)
        next_states = np.where(violation > round_off, other_states, trial_states)
        return tangential_forces, violation, next_states.astype(np.int8)

    return _forces_by_active_set(friction_step, node_states)


def _forces_by_active_set(
    active_set_step: Callable[[NodeSet], tuple[Forces, Array, NodeSet]], node_states: NodeSet
) -> tuple[Forces, NodeSet]:
    """Forces and node states (n,) at the end of an active-set iteration: a step is repeated until
    it changes no state.

    When a set of states comes back, only the node of the largest violation changes in that step:
    the iteration then does not cycle for ever. A state is whether the node touches; or open, stick
    or slip.

    Parameters
    ----------
    active_set_step
        function from node states to forces that meet their equations, the violation of each node's
        inequality, and the next states
    node_states
        (n,) to begin with

    Raises
    ------
    ConvergenceError
        Where the states still change after 200 steps.
    """
    earlier_sets: set[bytes] = set()  # node states of the steps so far
    for _ in range(_MOST_ITERATIONS):
        forces, violation, next_states = active_set_step(node_states)
        has_changed = next_states != node_states
        if not has_changed.any():
            return forces, node_states
        if next_states.tobytes() in earlier_sets:
            worst_node = int(np.argmax(np.where(has_changed, violation, -np.inf)))
            next_states = np.where(
                np.arange(len(node_states)) == worst_node, next_states, node_states
            )
        earlier_sets.add(next_states.tobytes())
        node_states = next_states
    raise ConvergenceError(
        f"contact: a convex half of the problem did not converge in {_MOST_ITERATIONS} iterations"
    )
