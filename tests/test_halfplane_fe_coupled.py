"""Coupled systems of unlike bodies: every set of states solved to rounding, whichever set was factorised."""

from collections import Counter

import numpy as np
import pytest

from halfplane_fe.active_subsets import CoupledFactor, SingularSet
from halfplane_fe.interface import Interface

N, FRICTION = 30, 0.7
RNG = np.random.default_rng(7)
OPEN, STICK, FORWARD, REVERSE = range(4)


def positive_definite() -> np.ndarray:
    half = RNG.standard_normal((N, N))
    return half @ half.T / N + np.eye(N)


def tilted() -> np.ndarray:
    slope = RNG.uniform(-0.2, 0.2, N)
    return np.stack([-slope, np.ones(N)]) / np.hypot(1, slope)


def factor(work: Counter[str] | None = None) -> CoupledFactor:
    zero, coupling = np.zeros(N), 0.1 * RNG.standard_normal((N, N))
    normal, tangential = positive_definite(), positive_definite()
    interface = Interface(np.linspace(-1, 1, N), zero + 1, tilted(), zero, normal, tangential, coupling)
    return CoupledFactor(interface, normal, tangential, coupling, FRICTION, Counter() if work is None else work)


def sets(count: int) -> list[np.ndarray]:
    """States that go on from each other, a few nodes at a time, and a jump."""
    states = np.full(N, STICK, dtype=np.int8)
    found = []
    for number in range(count):
        changed = RNG.choice(N, 3 if number % 7 else N, replace=False)
        states = states.copy()
        states[changed] = RNG.integers(0, 4, len(changed))
        states[N // 2] = STICK
        found.append(states)
    return found


def residual(one: CoupledFactor, states: np.ndarray, gap: np.ndarray, slip: np.ndarray, loads: tuple[float, float]) -> float:
    """Worst violation of the equations that the states name, written out afresh."""
    p, q, approach, shift = one.solve(states, gap, slip, loads)
    n_x, n_y = one.interface.normals
    found_gap = n_x * shift - n_y * approach + one.normal @ p - one.coupling.T @ q
    found_slip = n_y * shift + n_x * approach + one.coupling @ p - one.tangential @ q
    sign = np.select([states == FORWARD, states == REVERSE], [1.0, -1.0])
    rows = np.where(states == OPEN, p, found_gap - gap)
    tangential = np.where(states == STICK, found_slip - slip, q - sign * FRICTION * p)
    balance = [n_y @ p + n_x @ q - loads[0], n_y @ q - n_x @ p - loads[1]]
    return float(np.abs(np.concatenate([rows, tangential, balance])).max())


def test_every_set_is_solved_to_rounding_and_few_are_factorised():
    work: Counter[str] = Counter()
    one = factor(work)
    for states in sets(40):
        gap, slip = RNG.standard_normal(N), RNG.standard_normal(N)
        assert residual(one, states, gap, slip, (1.0, 0.3)) < 1e-11
    assert work["linear solves"] == 40
    assert work["factorisations"] < 12
    assert 30 <= work["factorisations"] + work["factor updates"] <= 40


def test_a_set_met_again_costs_no_factors():
    work: Counter[str] = Counter()
    one, known = factor(work), sets(10)
    for states in known:
        one.solve(states, np.ones(N), np.zeros(N), (1.0, 0.0))
    once = work["factorisations"] + work["factor updates"]
    for states in known:
        one.solve(states, np.zeros(N), np.ones(N), (0.0, 1.0))
    assert work["factorisations"] + work["factor updates"] == once <= 10


def test_bodies_that_nothing_holds_are_no_answer():
    one = factor()
    with pytest.raises(SingularSet):
        one.solve(np.full(N, FORWARD, dtype=np.int8), np.ones(N), np.zeros(N), (1.0, 0.0))
    near = np.full(N, FORWARD, dtype=np.int8)
    near[3] = STICK
    one.solve(near, np.ones(N), np.zeros(N), (1.0, 0.0))  # a base from which the set above is one row away
    with pytest.raises(SingularSet):
        one.solve(np.full(N, FORWARD, dtype=np.int8), np.ones(N), np.zeros(N), (1.0, 0.0))


def test_that_test_sees_a_column_of_another_row(monkeypatch):
    """Planted: a change taken for that of the next node."""
    true = CoupledFactor._from
    monkeypatch.setattr(
        CoupledFactor, "_from", lambda self, base, rows: true(self, base, rows._replace(closed=np.roll(rows.closed, 1)))
    )
    one = factor()
    worst = max(residual(one, states, np.ones(N), np.zeros(N), (1.0, 0.3)) for states in sets(6))
    assert worst > 1e-3
