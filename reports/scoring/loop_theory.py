"""The cycle of a scene as a loop of Q over U: its loads, and U by theory and by finite elements.

# notation: f friction coefficient, P and Q loads, U relative displacement
"""

from __future__ import annotations

import numpy as np

import semi_analytic
from reports.checking import nearest_to_sliding
from scenes import Scene
from scenes.array_types import Array

# Instants of a cycle at which theory is evaluated, straight between: an error of 1e-5 of the range
# of U.
N_INSTANTS = 721
SHARES_OF_CYCLE = np.linspace(0.0, 1.0, N_INSTANTS)
# Rows without noise show the chords between instants: to 1e-5 of f they need three times as many.
FINE_SHARES_OF_CYCLE = np.linspace(0.0, 1.0, 3 * (N_INSTANTS - 1) + 1)


def friction_at_gross_sliding(scene: Scene) -> float:
    """Friction coefficient f at which the contact just slides as a whole at the scene's loads."""
    # ratio: of |Q| to f P at the instant nearest to sliding
    return nearest_to_sliding(scene).ratio * scene.friction.coefficient * (1 + 1e-9)


def has_two_branches(scene: Scene) -> bool:
    """Whether Q has one highest and one lowest value in a cycle, and no other turning point."""
    tangential_load = cycle_loads(scene)[1]
    steps = np.diff(tangential_load)
    signs = np.sign(steps[np.abs(steps) > 1e-9 * np.ptp(tangential_load)])
    return bool(len(signs) > 0 and np.count_nonzero(signs[1:] != signs[:-1]) <= 2)


def has_constant_normal_load(scene: Scene) -> bool:
    """Whether the normal load P is constant through a cycle of the scene."""
    normal_loads = cycle_loads(scene)[0]
    return bool(np.ptp(normal_loads) <= 1e-9 * normal_loads.max())


def times_of_cycle(scene: Scene, shares: Array) -> Array:
    """Times of the load path, (n,), at `shares` (n,) of the last cycle of the scene, at least the
    second one.
    """
    path = scene.load.path()
    assert path.period is not None
    return path.cycle_start + path.period * (max(scene.cycles, 2) - 1 + shares)


def cycle_loads(scene: Scene, shares: Array = SHARES_OF_CYCLE) -> tuple[Array, Array]:
    """P and Q of the scene at `shares` (n,) of its last cycle, (n,) each [force per thickness]."""
    normal_load, tangential_load = scene.load.path().at(times_of_cycle(scene, shares))
    return np.asarray(normal_load), np.asarray(tangential_load)


def theory_displacement(scene: Scene, friction: float, shares: Array = SHARES_OF_CYCLE) -> Array:
    """Relative tangential displacement U of the steady cycle by half-plane theory [length], with
    another `friction` coefficient, at `shares` (n,) of the cycle.
    """
    varied_scene = scene.vary(friction=friction, cycles=max(scene.cycles, 2))
    solution = semi_analytic.solve(
        varied_scene,
        x=0.0,
        time=times_of_cycle(scene, shares),
        fields="tangential_displacement",
        cycles="steady",
    )
    return solution.tangential_displacement


def finite_element_displacement(scene: Scene, friction: float) -> Array:
    """Relative tangential displacement U of the last cycle by finite elements [length], with
    another `friction` coefficient, interpolated to the instants `SHARES_OF_CYCLE` (0 to 1) of the
    cycle.
    """
    import halfplane_fe

    solution = halfplane_fe.solve(scene.vary(friction=friction))
    path = scene.load.path()
    # indices of the instants of the last cycle
    cycle_indices = solution.last_cycle
    assert path.period is not None
    # share of the cycle at each of these instants, from 0 to 1
    shares = (solution.time[cycle_indices] - path.cycle_start) / path.period
    shares -= round(float(shares[0]))  # without the whole cycles before
    return np.interp(SHARES_OF_CYCLE, shares, solution.tangential_displacement[cycle_indices])
