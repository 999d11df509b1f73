r"""Unilateral contact and Coulomb friction at a point, as pure functions: no mesh, no history, no
scale.

With gap g >= 0, pressure p >= 0, slip increment ds of the upper face and shear q on the lower one:

    Signorini   g >= 0,  p >= 0,  g p = 0
    Coulomb     |q| <= f p,  ds = 0 where |q| < f p,  ds q >= 0 where |q| = f p

Both are one projection: for any r > 0, (p, q) = project(p - r g, q + r ds). The penalty law is the
same projection with an elastic layer between the faces, p = project(-g/k_n), q = project(q_old +
ds/k_t): see `systems.Layer`.

Of an increment: which nodes start to slide in it, and by how much its friction work may be wrong.

Source: Alart and Curnier (1991), Simo and Laursen (1992); return mapping as in plasticity.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK
from scenes.array_types import Array, Mask, States

_SIGN_OF_STATE = np.zeros(4, dtype=np.int64)
_SIGN_OF_STATE[SLIP_FORWARD] = 1
_SIGN_OF_STATE[SLIP_REVERSE] = -1
_OPEN, _STICK, *_SLIPS = np.array([OPEN, STICK, SLIP_FORWARD, SLIP_REVERSE], dtype=np.int8)


def project(
    trial_pressure: ArrayLike, trial_shear: ArrayLike, friction: float
) -> tuple[Array, Array, States]:
    """Return mapping of contact and friction: trial pressure and shear are projected onto the
    Coulomb cone, p >= 0 and |q| <= f p.

    A negative pressure becomes 0. Then a shear beyond the Coulomb limit at that pressure becomes
    the limit, with its sign.

    Parameters
    ----------
    trial_pressure, trial_shear
        any shape, one for both [stress, or force on a node]
    friction
        coefficient f >= 0

    Returns
    -------
    pressure, shear
        p and q, inside the cone or on it
    states
        0 open, 1 stick, 2 slip forward (q > 0), 3 slip reverse (q < 0), int8

    Examples
    --------
    >>> p, q, states = project([-1.0, 2.0, 2.0], [0.3, 0.5, -3.0], 0.5)
    >>> p.tolist(), q.tolist(), states.tolist()
    ([0.0, 2.0, 2.0], [0.0, 0.5, -1.0], [0, 1, 3])
    """
    pressure = np.maximum(np.asarray(trial_pressure, dtype=float), 0.0)
    unlimited_shear = np.asarray(trial_shear, dtype=float)
    limit = friction * pressure  # f p
    # Several times as fast as np.clip.
    shear = np.minimum(np.maximum(unlimited_shear, -limit), limit)
    is_closed = np.asarray(trial_pressure) > 0
    states = np.where(is_closed, states_if_closed(unlimited_shear, limit), _OPEN)
    return pressure, shear, states


def states_if_closed(trial_shear: Array, limit: Array) -> States:
    """Contact states (...) of closed nodes: stick, or slip in the sense of the trial shear where it
    exceeds the Coulomb limit f p.

    >>> states_if_closed(np.array([0.5, -3.0]), np.array([1.0, 1.0])).tolist()
    [1, 3]
    """
    # _SLIPS: the states slip forward and slip in reverse; _STICK: stick
    sense_of_slip = np.where(trial_shear > 0, *_SLIPS)
    return np.where(np.abs(trial_shear) > limit, sense_of_slip, _STICK)


def force_to_limit(
    pressure: Array, shear: Array, sense: Array | NDArray[np.int64] | int, friction: float
) -> Array:
    """Distance f p - s q of the shear q from the Coulomb limit, for a sense of slip s, 1 or -1.

    It has the shape and the units of p and q, and falls to zero where a node starts to slide. With
    rates of p and q it is the rate of this distance.

    >>> float(force_to_limit(np.array(2.0), np.array(-0.5), -1, 0.5))
    0.5
    """
    return np.asarray(friction * pressure - sense * shear)


def slip_sign(state: States) -> NDArray[np.int64]:
    """+1 where a point slips forward, -1 where it slips in reverse, else 0; any shape.

    >>> slip_sign(np.array([0, 1, 2, 3], dtype=np.int8)).tolist()
    [0, 0, 1, -1]
    """
    return _SIGN_OF_STATE.take(state)  # half the time of _SIGN_OF_STATE[state]


def violations(
    gap: Array, pressure: Array, shear: Array, slip_increment: Array, friction: float
) -> dict[str, Array]:
    """How far a solution is from the laws of unilateral contact and Coulomb friction: the largest
    violation of each law over n nodes, 0 where it is met.

    Parameters
    ----------
    gap, pressure, shear, slip_increment
        (..., n) g, p, q and the increment ds of slip at the nodes
    friction
        coefficient f

    Returns
    -------
    dict
        Name of a law -> (...) violation, in the units of the arguments: tension (-p), penetration
        (-g), gap_pressure (|g p|), cone (|q| - f p), slip_sign (-q ds, as if friction did work),
        creep (|ds| where |q| < f p).
    """
    limit = friction * pressure  # f p
    is_below_limit = np.abs(shear) < limit * (1 - 1e-9)
    is_closed = pressure > 0
    nodal_violations = {
        "tension": -pressure,
        "penetration": -gap,
        "gap_pressure": np.abs(gap * pressure),
        "cone": np.abs(shear) - limit,
        "slip_sign": np.where(is_closed, -(shear * slip_increment), 0.0),
        "creep": np.where(is_below_limit & is_closed, np.abs(slip_increment), 0.0),
    }
    return {name: np.max(values, axis=-1, initial=0.0) for name, values in nodal_violations.items()}


def is_slip_onset(node_states_before: States, node_states_after: States) -> Mask:
    """Whether each node starts to slide, or turns round: it slides after an increment and did not
    slide that way before. All arrays have one shape (...).
    """
    sense = slip_sign(node_states_after)
    return (sense != 0) & (sense != slip_sign(node_states_before))


def step_errors(
    friction: float,
    pressure_change: Array,
    slip_change: Array,
    node_states_before: States,
    node_states_after: States,
) -> Array:
    """Bound (...) of the error of the dissipation of increments: f |dp| |ds| / 2 of the nodes that
    start to slide in them.

    `friction` is the coefficient f. `pressure_change` and `slip_change` are dp and ds of the
    increment. `node_states_before` and `node_states_after` are open, stick or slip of the nodes.
    Each is (..., n), scaled.
    """
    starts_to_slide = is_slip_onset(node_states_before, node_states_after)
    products = np.where(starts_to_slide, np.abs(pressure_change * slip_change), 0.0)
    return np.asarray(friction * products.sum(axis=-1) / 2)
