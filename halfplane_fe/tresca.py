"""The two halves of the contact problem on their own, each convex, each solved from any start.

Unilateral contact at known shear, and friction at known pressure (Tresca's law, |q| <= f p with p
given).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve
from scipy.optimize import brentq

from halfplane_fe.systems import SingularSet, Systems
from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, ConvergenceError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
States = NDArray[np.int8]

_ITERATIONS = 200


def pressure_at_known_shear(
    systems: Systems, height: Array, load: float, closed: Mask, rounding: float
) -> tuple[Array, float, Mask]:
    """Pressure (n,), approach and closed nodes of g = height - n_y delta + N p >= 0, p >= 0, g p =
    0, n_y p = load (active set).

    Parameters
    ----------
    height : (n,) initial gap with the parts of the known shear and shift in it
    closed : where to start

    >>> from halfplane_fe.interface import Interface
    >>> from halfplane_fe.systems import Layer
    >>> springs, none = np.eye(2), np.zeros(2)  # two nodes, each on a spring of its own
    >>> flat = Interface(
    ...     np.array([0.0, 1.0]),
    ...     np.ones(2),
    ...     np.array([[0.0, 0.0], [1.0, 1.0]]),
    ...     none,
    ...     springs,
    ...     springs,
    ...     None,
    ... )
    >>> height, start = np.array([0.0, 1.0]), np.array([True, False])
    >>> pressure, approach, closed = pressure_at_known_shear(
    ...     Systems(flat, Layer(none, none), 0.5), height, 3.0, start, 1e-12
    ... )
    >>> pressure.tolist(), approach, closed.tolist()  # approach 2, the second node meets after 1
    ([2.0, 1.0], 2.0, [True, True])
    """

    approach, n_y = 0.0, systems.interface.normals[1]

    def step(closed: Mask) -> tuple[Array, Array, Mask]:
        nonlocal approach
        if not closed.any():
            raise SingularSet("no node holds the normal load")
        by_height, by_approach = solve(
            systems.normal[np.ix_(closed, closed)],
            np.stack([-height[closed], n_y[closed]], axis=1),
            assume_a="pos",
        ).T
        approach = (load - n_y[closed] @ by_height) / (n_y[closed] @ by_approach)
        pressure = np.zeros_like(height)
        pressure[closed] = by_height + approach * by_approach
        gap = height - n_y * approach + systems.normal @ pressure
        wrong = np.where(closed, -pressure, -gap)
        return pressure, wrong, np.where(wrong > rounding, ~closed, closed)

    pressure, closed = _settled(step, closed)
    return pressure, float(approach), closed


def shear_at_known_pressure(
    systems: Systems, pressure: Array, known_slip: Array, load: float | None, rounding: float
) -> tuple[Array, float, States]:
    """Shear (n,), shift and states of |q| <= f p, slip n_y U - T q - known_slip only where |q| = f
    p and along q, n_y q = load.

    The sum of n_y q grows with the shift U from -f P to f P, so U is found by bracketing; without a
    `load` it is zero.

    >>> from halfplane_fe.interface import Interface
    >>> from halfplane_fe.systems import Layer
    >>> springs, none = np.eye(2), np.zeros(2)  # two nodes, each on a spring of its own
    >>> flat = Interface(
    ...     np.array([0.0, 1.0]),
    ...     np.ones(2),
    ...     np.array([[0.0, 0.0], [1.0, 1.0]]),
    ...     none,
    ...     springs,
    ...     springs,
    ...     None,
    ... )
    >>> systems, pressure = Systems(flat, Layer(none, none), 0.5), np.array([0.2, 1.0])
    >>> shear, shift, states = shear_at_known_pressure(systems, pressure, none, 0.5, 1e-12)
    >>> (
    ...     shear.round(12).tolist(),
    ...     round(shift, 12),
    ...     states.tolist(),
    ... )  # the first node slips at f p = 0.1, the second holds the rest
    ([0.1, 0.4], 0.4, [2, 1])
    """
    n_y = systems.interface.normals[1]
    limit = systems.friction * pressure
    closed = pressure > 0
    states = np.where(closed, STICK, OPEN).astype(np.int8)
    most = (
        np.abs(known_slip[closed]).max() + np.abs(systems.tangential @ limit)[closed].max()
    ) / n_y.min()

    def shear(shift: float) -> Array:
        nonlocal states
        found, states = _bounded(systems, limit, known_slip - n_y * shift, states, rounding)
        return found

    if load is None:
        return shear(0.0), 0.0, states
    shift = float(
        brentq(
            lambda u: float(n_y @ shear(u)) - load,
            -most,
            most,
            xtol=1e-13 * max(most, 1e-300),
            rtol=8.9e-16,
        )
    )
    return shear(shift), shift, states


def _bounded(
    systems: Systems, limit: Array, known: Array, states: States, rounding: float
) -> tuple[Array, States]:
    """Shear and states of |q| <= limit, -T q - known = 0 inside, >= 0 at the upper bound, <= 0 at
    the lower one.
    """
    sign = {SLIP_FORWARD: 1.0, SLIP_REVERSE: -1.0}

    def step(states: States) -> tuple[Array, Array, States]:
        stick = states == STICK
        shear = sum(
            (value * limit * (states == state) for state, value in sign.items()),
            np.zeros_like(limit),
        )
        if stick.any():
            known_there = (-known - systems.tangential @ shear)[stick]
            shear[stick] = solve(
                systems.tangential[np.ix_(stick, stick)], known_there, assume_a="pos"
            )
        slip = -systems.tangential @ shear - known
        forward, reverse = states == SLIP_FORWARD, states == SLIP_REVERSE
        wrong = np.where(
            stick, np.abs(shear) - limit, np.where(forward, -slip, np.where(reverse, slip, -np.inf))
        )
        turned = np.where(shear > 0, SLIP_FORWARD, SLIP_REVERSE)
        wanted = np.where(wrong > rounding, np.where(stick, turned, STICK), states)
        return shear, wrong, wanted.astype(np.int8)

    return _settled(step, states)


def _settled(
    step: Callable[[NDArray], tuple[Array, Array, NDArray]], states: NDArray
) -> tuple[Array, NDArray]:
    """Repeat `step` (states -> answer, violation, wanted states) until the states stay; the worst
    node alone once they recur.
    """
    seen: set[bytes] = set()
    for _ in range(_ITERATIONS):
        answer, wrong, wanted = step(states)
        changes = wanted != states
        if not changes.any():
            return answer, states
        if wanted.tobytes() in seen:
            worst = int(np.argmax(np.where(changes, wrong, -np.inf)))
            wanted = np.where(np.arange(len(states)) == worst, wanted, states)
        seen.add(wanted.tobytes())
        states = wanted
    raise ConvergenceError(
        f"contact: a convex half of the problem did not settle in {_ITERATIONS} iterations"
    )
